# talus.h compiles by itself, and talus_mpi.h with MPI's header, first in a file and twice, as C99, C11, C++17 and C++20 with gcc
# and clang, where no warning is let pass. What a host's compiler would say is nothing.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
include=$TALUS_SOURCE_DIR/capi/include
strict=(-Wall -Wextra -pedantic -Werror -Wshadow -Wconversion -Wundef -Wstrict-prototypes -fsyntax-only)
skipped=()

# A function is called and every struct is used, since an unused static inline or typedef could hide a fault.
use='int main(void) { talus_settings s; talus_state t; return talus_settings_init(&s) + talus_state_init(&t); }'
printf '#include "talus.h"\n#include "talus.h"\n%s\n' "$use" >"$work/plain.c"
printf '#include "talus_mpi.h"\n#include "talus.h"\n#include "talus_mpi.h"\n%s\n' \
    "static talus_status make(talus_settings *s, talus_engine **e) { return talus_engine_create_comm(s, MPI_COMM_WORLD, e); }
int main(void) { return make(0, 0); }" >"$work/mpi.c"
cp "$work/plain.c" "$work/plain.cpp"
sed 's/make(0, 0)/make(nullptr, nullptr)/' "$work/mpi.c" >"$work/mpi.cpp"

compile() { # COMPILER STANDARD FILE [FLAGS...]
    local flags=("${strict[@]}")
    [[ $3 != *.cpp ]] || flags=("${flags[@]/-Wstrict-prototypes/-Wold-style-cast}")
    [[ $3 != *mpi.cpp ]] || flags=("${flags[@]/-Wold-style-cast/-Wextra}") # MPI_COMM_WORLD is a C cast
    "$1" "-std=$2" "${flags[@]}" -I "$include" "${@:4}" "$work/$3" || { echo "failed: $1 -std=$2 $3" >&2; exit 1; }
}
for family in gcc:g++ clang:clang++; do
    c=${family%:*} cxx=${family#*:}
    command -v "$cxx" >/dev/null || { skipped+=("$c"); continue; }
    for standard in c99 c11; do compile "$c" $standard plain.c; done
    for standard in c++17 c++20; do compile "$cxx" $standard plain.cpp; done
    # MPI's own header is not ours to judge: its folders are the system's. So are the C++ bindings that it still has.
    command -v mpicc >/dev/null || { skipped+=("MPI with $c"); continue; }
    mapfile -t mpi < <(OMPI_CC=$c mpicc --showme:incdirs 2>/dev/null | tr ' ' '\n' | sed 's/^/-isystem/')
    for standard in c99 c11; do compile "$c" $standard mpi.c "${mpi[@]}"; done
    for standard in c++17 c++20; do compile "$cxx" $standard mpi.cpp "${mpi[@]}" -DOMPI_SKIP_MPICXX -DMPICH_SKIP_MPICXX; done
done
# And as a user of MPI does it.
for wrapper in mpicc:c mpicxx:cpp; do
    command -v "${wrapper%:*}" >/dev/null || { skipped+=("${wrapper%:*}"); continue; }
    "${wrapper%:*}" -Wall -Wextra -Werror -fsyntax-only -DOMPI_SKIP_MPICXX -I "$include" "$work/mpi.${wrapper#*:}"
done

if ((${#skipped[@]})); then
    echo "SKIPPED, not installed: ${skipped[*]}; all others are clean"
    exit 77
fi
