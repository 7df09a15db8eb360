# The list of symbols in capi/ABI.md is the library's, in the header's order and under its headings, each with its version.
set -euo pipefail
library=$TALUS_BUILD_DIR/lib/libtalus.so
page=$TALUS_SOURCE_DIR/capi/ABI.md
[[ -e $library ]] || { echo "$library is not built" >&2; exit 1; }

same() { # WHAT A B
    [[ $2 == "$3" ]] || { echo "$1 (<) and (>) differ:" >&2; diff <(echo "$2") <(echo "$3") >&2; exit 1; }
}
listed=$(sed -nE 's/^\| `(talus_[a-z0-9_]+)` \| [0-9]+\.[0-9]+\.[0-9]+ \|$/\1/p' "$page")
[[ -n $listed ]] || { echo "no list found in $page" >&2; exit 1; }
same "ABI.md, libtalus.so" "$(sort <<<"$listed")" "$(nm -D --defined-only "$library" | awk '{ print $3 }' | sed 's/@.*//' | sort)"

# Headings and order as in talus.h, where one finds what the functions do.
in_page=$(sed -n '/^## Symbols/,/^## How/p' "$page" | sed -nE 's/^### (.*)/\L\1/p; s/^\| `(talus_[a-z0-9_]+)`.*/\1/p')
in_header=$(sed -nE 's|^/\* ---- (.*[a-z]) -+ \*/$|# \1|p; s/^TALUS_API .*[ *](talus_[a-z0-9_]+)\(.*/\1/p' \
    "$TALUS_SOURCE_DIR/capi/include/talus.h" |
    awk '/^#/ { heading = substr($0, 3); next } heading != "" { print heading; heading = "" } { print }')
same "ABI.md, talus.h" "$in_page" "$in_header"
