# The shared library shows exactly the functions that talus.h declares: nothing of C++ leaks, nothing is forgotten.
set -euo pipefail
library=$TALUS_BUILD_DIR/lib/libtalus.so
[[ -e $library ]] || { echo "$library is not built" >&2; exit 1; }

declared=$(sed -n 's/^TALUS_API .*[ *]\(talus_[a-z_]*\)(.*/\1/p' "$TALUS_SOURCE_DIR/capi/include/talus.h" | sort)
shown=$(nm -D --defined-only "$library" | awk '{ print $3 }' | sed 's/@.*//' | sort)
if [[ $declared != "$shown" ]]; then
    echo "declared in talus.h (<) and shown by $library (>) differ:" >&2
    diff <(echo "$declared") <(echo "$shown") >&2
    exit 1
fi
