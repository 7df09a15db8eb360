# What is compiled for AVX-512 keeps to itself: no function of that object but the kernels' entry may be one that the linker could
# give to callers on other processors (inline functions, templates not over eight lanes).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
ar x "$TALUS_BUILD_DIR/lib/libtalus_core.a" kernel_avx512.cpp.o
nm -C --defined-only kernel_avx512.cpp.o | awk '$2 ~ /[TW]/' >all
[[ -s all ]] || exit 77 # kernels of eight lanes are in optimised builds only
grep -q 'V8' all
if grep -v 'V8' all | grep -v 'T talus::core::select_avx512('; then
    echo "these functions are compiled for AVX-512 and could be called by everyone" >&2
    exit 1
fi
