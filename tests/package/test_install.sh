# timeout: 300
# An installed Talus, moved to another place, is found by CMake and by pkg-config, and C and Python programs run with it.
set -euo pipefail
[[ -z ${TALUS_SANITIZE:-} ]] || exit 77 # a user's program is not built with our sanitizers

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --install "$TALUS_BUILD_DIR" --prefix "$work/first" >"$work/log" || { cat "$work/log" >&2; exit 1; }
mv "$work/first" "$work/moved"

mkdir "$work/user"
cat >"$work/user/main.c" <<'C'
#include <stdio.h>
#include <talus.h>
int main(void) { puts(talus_build_info()); return talus_version() != TALUS_VERSION_NUMBER; }
C
cat >"$work/user/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.25)
project(user C)
find_package(Talus 0.1 REQUIRED)
add_executable(user main.c)
target_link_libraries(user Talus::talus)
CMAKE

cmake -S "$work/user" -B "$work/user/build" -DCMAKE_PREFIX_PATH="$work/moved" >"$work/log"
cmake --build "$work/user/build" >>"$work/log" || { cat "$work/log" >&2; exit 1; }
"$work/user/build/user"

pc=$(dirname "$(find "$work/moved" -name talus.pc)")
lib=$(dirname "$(find "$work/moved" -name libtalus.so)")
flags=$(PKG_CONFIG_PATH=$pc pkg-config --cflags --libs talus)
# shellcheck disable=SC2086 # several words on purpose
cc "$work/user/main.c" $flags -Wl,-rpath,"$lib" -o "$work/user/by_pkg_config"
"$work/user/by_pkg_config"

# The Python package finds the library of its own prefix.
package=$(dirname "$(dirname "$(find "$work/moved" -path '*/talus/__init__.py')")")
env -u TALUS_LIBRARY PYTHONPATH="$package" /usr/bin/python3 -B -c \
    'import sys, talus; print(talus.build_info()); assert talus._library.lib._name.startswith(sys.argv[1])' "$(realpath "$lib")"

# The driver is installed beside the library and finds it wherever both were moved.
sandbox=$work/moved/bin/talus-sandbox
[[ ! -e $sandbox ]] || "$sandbox" --version
