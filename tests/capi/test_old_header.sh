# A program compiled against the first talus.h runs with today's library: old_header.c, which also looks that not a byte behind
# its own, shorter structs is written.
set -euo pipefail
[[ -z ${TALUS_SANITIZE:-} ]] || exit 77 # a user's program is not built with our sanitizers

library=$TALUS_BUILD_DIR/lib
[[ -e $library/libtalus.so ]] || { echo "$library/libtalus.so is not built" >&2; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cc -std=c99 -Wall -Wextra -pedantic -Werror "$TALUS_SOURCE_DIR/tests/capi/old_header.c" \
    -L"$library" -ltalus -Wl,-rpath,"$library" -o "$work/old_header"
"$work/old_header"
