# timeout: 240
# processors: 2
# An installed Talus, moved to another place, serves strangers: the examples of apps/embed are built there by find_package, by
# pkg-config and for dlopen, without a warning, and run; the heap has one digest, serial or on ranks, whoever built it. What
# else is installed (driver, man pages, completion, licence) is there and works, too.
set -euo pipefail
[[ -z ${TALUS_SANITIZE:-} ]] || exit 77 # a user's program is not built with our sanitizers

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
quietly() { # COMMAND...: its output only if it fails
    "$@" >"$work/log" 2>&1 || { cat "$work/log" >&2; echo "failed: $*" >&2; exit 1; }
}
fail() {
    echo "$*" >&2
    exit 1
}
digest_of() { sed -n 's/^digest //p' "$1"; }

quietly cmake --install "$TALUS_BUILD_DIR" --prefix "$work/first"
mv "$work/first" "$work/moved"
prefix=$work/moved
lib=$(dirname "$(find "$prefix" -name libtalus.so)")

# The Python package finds the library of its own prefix.
package=$(dirname "$(dirname "$(find "$prefix" -path '*/talus/__init__.py')")")
quietly env -u TALUS_LIBRARY PYTHONPATH="$package" /usr/bin/python3 -B -c \
    'import sys, talus; assert talus._library.lib._name.startswith(sys.argv[1])' "$(realpath "$lib")"

# The examples, as someone would have them who copied the folder.
cp -r "$TALUS_SOURCE_DIR/apps/embed" "$work/embed"
quietly cmake -S "$work/embed" -B "$work/by_cmake" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_COMPILE_WARNING_AS_ERROR=ON
quietly cmake --build "$work/by_cmake" -j2

# The command at the head of each, as it is printed there, but strict and with a way to find a library that is not installed
# in the system's place.
export PKG_CONFIG_PATH
PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name talus.pc)")
mkdir "$work/by_pkg_config"
sources=("$work"/embed/*.c "$work"/embed/*.cpp)
for source in "${sources[@]}"; do
    command=$(sed -nE 's/^(\/\/| \*) +((cc|c\+\+|mpicc) -std=.* -o [a-z_]+).*/\2/p' "$source")
    [[ -n $command ]] || fail "$source: no command to build it at its head"
    name=${command##* -o }
    (cd "$work/embed" && quietly bash -c "${command% -o *} -Wall -Wextra -pedantic -Werror -Wl,-rpath,$lib -o $work/by_pkg_config/$name")
done
((${#sources[@]} == 5)) || fail "there are ${#sources[@]} examples; this test knows five"

run() { # OUTPUT COMMAND...: exit code 0 and nothing said on the error stream
    "${@:2}" >"$work/$1" 2>"$work/$1.err" || { cat "$work/$1" "$work/$1.err" >&2; fail "exit code $?: ${*:2}"; }
}
refused() { # CODE COMMAND...: that exit code, and a message
    local code=0
    "${@:2}" >/dev/null 2>"$work/err" || code=$?
    ((code == $1)) && [[ -s $work/err ]] || fail "exit code $code, message \"$(cat "$work/err")\", wanted $1 and some: ${*:2}"
}
in_mpi() { mpirun -n "$1" --oversubscribe --bind-to none --mca mpi_yield_when_idle 1 "${@:2}"; }

for built in by_cmake by_pkg_config; do
    bin=$work/$built
    run "$built.heap" "$bin/heap" 400 1
    run "$built.two_threads" "$bin/heap" 400 2
    run "$built.rank1" in_mpi 1 "$bin/heap_mpi" 400
    run "$built.rank3" in_mpi 3 "$bin/heap_mpi" 400
    run "$built.shear" "$bin/shear" 300
    run "$built.coupling" "$bin/coupling" 60
    run "$built.dlopen" "$bin/dlopen" "$lib/libtalus.so.0"

    digest=$(digest_of "$work/by_cmake.heap")
    [[ $digest =~ ^[0-9a-f]{32}$ ]] || fail "heap printed no digest: $(cat "$work/by_cmake.heap")"
    for other in heap two_threads rank1 rank3; do
        [[ $(digest_of "$work/$built.$other") == "$digest" ]] || fail "$built, $other: $(digest_of "$work/$built.$other"), not $digest"
    done
    refused 2 "$bin/heap" 0
    refused 1 "$bin/dlopen" "$work/no_such_library.so"
    refused 2 in_mpi 3 "$bin/heap_mpi" 0
done
cmp "$work/by_cmake.coupling" "$work/by_pkg_config.coupling" || fail "steps that were taken back and tried again left different states"
number=$(printf '#include <talus.h>\nTALUS_VERSION_NUMBER\n' | cc -E -P -I "$prefix/include" - | tail -1)
grep -q "^library $((number))," "$work/by_cmake.dlopen" || fail "header and library differ in version"
! readelf -d "$work/by_cmake/dlopen" | grep -q 'NEEDED.*talus' || fail "the dlopen example is linked with Talus"

# Sand: neither a liquid nor a brick.
awk '/^angle of repose/ { found = $4 > 15 && $4 < 40 } END { exit !found }' "$work/by_cmake.heap" || fail "$(cat "$work/by_cmake.heap")"
awk '/^stress ratio/ { found = $3 > 0.2 && $3 < 0.7 } END { exit !found }' "$work/by_cmake.shear" || fail "$(cat "$work/by_cmake.shear")"

# The rest of what is installed: the driver finds the library wherever both were moved, and pages and completion are where
# man and bash look for them.
sandbox=$prefix/bin/talus-sandbox
if [[ -e $sandbox ]]; then
    run sandbox "$sandbox" --version
    for file in man/man1/talus-sandbox.1 bash-completion/completions/talus-sandbox talus/configs/slice.toml; do
        [[ -s $prefix/share/$file ]] || fail "share/$file is not installed"
    done
fi
for file in share/man/man3/talus.3 share/doc/Talus/LICENSE share/doc/Talus/ABI.md include/talus.h include/talus_mpi.h; do
    [[ -s $prefix/$file ]] || fail "$file is not installed"
done
cat "$work/by_cmake.heap" "$work/by_cmake.rank3" "$work/by_cmake.shear" "$work/by_cmake.coupling" "$work/by_cmake.dlopen"
