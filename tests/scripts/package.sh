#!/bin/sh
# package.sh - from outside: installs into a folder, and builds and runs one program with pkg-config and with CMake in four
# ways (subdirectory, FetchContent, find_package after make install and after CMake's own) and a library for others;
# unpacks make dist, builds and installs from it; uninstalls.
# Last line: "package: N passed, N failed, N skipped".
root=$PWD
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
passed=0 failed=0 skipped=0

check() {       # check NAME COMMAND...
    name=$1
    shift
    if "$@" > "$dir/log" 2>&1; then
        echo "  passed: $name"
        passed=$((passed + 1))
    else
        echo "  FAILED: $name"
        tail -n 12 "$dir/log"
        failed=$((failed + 1))
    fi
}
leave() {
    echo "  skipped: $1 ($2 is not installed)"
    skipped=$((skipped + 1))
}

mkdir "$dir/user"
{
    # Private copies, of which next to nothing is compiled: the way to the headers is what is tried. All the names come first,
    # since a header that another one includes is in this file, too, and private.
    for h in $HEADERS; do
        printf '#define %s_STATIC\n' "$(sh tools/prefix "$h" | tr a-z A-Z)"
        printf '#define %s_IMPLEMENTATION\n' "$(basename "$h" .h | tr a-z A-Z)"
    done
    printf '#include <%s>\n' $HEADERS
    cat <<'EOF'
#include <stdio.h>
int main(void)
{
    printf("%s, csm.h %d, shadowfield.h %d\n", cohsm_result_text(COHSM_OK), COHSM_VERSION, SFIELD_VERSION);
    return cohsm_result_text(COHSM_OK)[0] != 'o';
}
EOF
} > "$dir/user/user.c"
cmake_user() {  # cmake_user LINE: a project that gets at dapple by that line
    rm -rf "$dir/build"
    printf 'cmake_minimum_required(VERSION 3.14)\nproject(user C)\n%s\nadd_executable(user user.c)\n%s\n' "$1" \
        'target_link_libraries(user PRIVATE dapple::dapple)' > "$dir/user/CMakeLists.txt"
    cmake -S "$dir/user" -B "$dir/build" -DCMAKE_PREFIX_PATH="$dir/there" && cmake --build "$dir/build" && "$dir/build/user"
}
exported() {    # a static library that is made of these headers, installed and found from a third project
    mkdir -p "$dir/library" "$dir/third"
    printf '#define CSM_IMPLEMENTATION\n#include <csm.h>\nint ours(void);\nint ours(void) { return COHSM_VERSION; }\n' \
        > "$dir/library/ours.c"
    printf 'int ours(void);\nint main(void) { return ours() <= 0; }\n' > "$dir/third/third.c"
    cat > "$dir/library/CMakeLists.txt" <<EOF
cmake_minimum_required(VERSION 3.14)
project(ours C)
set(DAPPLE_INSTALL ON)
add_subdirectory($root dapple)
add_library(ours STATIC ours.c)
target_link_libraries(ours PRIVATE dapple::dapple)
install(TARGETS ours EXPORT ours ARCHIVE DESTINATION lib)
install(EXPORT ours FILE ours-config.cmake DESTINATION lib/cmake/ours)
EOF
    cat > "$dir/third/CMakeLists.txt" <<EOF
cmake_minimum_required(VERSION 3.14)
project(third C)
find_package(dapple REQUIRED)
find_package(ours REQUIRED)
add_executable(third third.c)
target_link_libraries(third PRIVATE ours)
EOF
    cmake -S "$dir/library" -B "$dir/library/build" -DCMAKE_INSTALL_PREFIX="$dir/ours" &&
        cmake --build "$dir/library/build" --target install &&
        cmake -S "$dir/third" -B "$dir/third/build" -DCMAKE_PREFIX_PATH="$dir/ours" &&
        cmake --build "$dir/third/build" && "$dir/third/build/third"
}
refused() {
    ! cmake_user "find_package(dapple $((${VERSION%%.*} + 1)) REQUIRED)" && grep -q 'version: ' "$dir/log"
}
with_pkg_config() {
    # shellcheck disable=SC2046
    cc -std=c99 -O1 "$dir/user/user.c" $(PKG_CONFIG_PATH="$dir/there/lib/pkgconfig" pkg-config --cflags --libs dapple) -o \
        "$dir/with_pc" && "$dir/with_pc" && [ "$(PKG_CONFIG_PATH="$dir/there/lib/pkgconfig" pkg-config --modversion dapple)" = "$VERSION" ]
}
staged() {
    make -s install PREFIX=/opt/dapple DESTDIR="$dir/stage" && [ -f "$dir/stage/opt/dapple/include/csm.h" ] &&
        grep -q '^includedir=/opt/dapple/include$' "$dir/stage/opt/dapple/lib/pkgconfig/dapple.pc"
}
uninstalled() {
    make -s uninstall PREFIX="$dir/there" && [ -z "$(find "$dir/there" -name '*.h' -o -name '*.pc' -o -name '*.cmake')" ]
}
from_dist() {
    make -s dist && tar xzf "build/dapple-$VERSION.tar.gz" -C "$dir" && (cd "$dir/dapple-$VERSION" &&
        cc -std=c99 -O1 -I. "$dir/user/user.c" -lm -o "$dir/from_dist" && "$dir/from_dist" && make -s DEPS=0 build/01_csm_minimal &&
        make -n DEPS=0 | grep -q 'build/render')    # what make alone builds
}

fresh() {       # sudo make install in a fresh copy would leave a build folder of root's
    rm -rf "$dir/dapple-$VERSION" && tar xzf "build/dapple-$VERSION.tar.gz" -C "$dir" &&
        make -s -C "$dir/dapple-$VERSION" install PREFIX="$dir/fresh" && [ -f "$dir/fresh/include/csm.h" ] &&
        make -s -C "$dir/dapple-$VERSION" uninstall PREFIX="$dir/fresh" && [ ! -e "$dir/dapple-$VERSION/build" ]
}

# The settings of the make that calls this would reach the makes below.
unset MAKEFLAGS MFLAGS PREFIX INCLUDEDIR LIBDIR DESTDIR
# For CMake's compilers: without optimisation gcc keeps what nothing calls.
export CFLAGS=-O1
check 'make install PREFIX=' make -s install PREFIX="$dir/there"
check 'make install DESTDIR=' staged
if command -v pkg-config >/dev/null 2>&1; then check 'pkg-config' with_pkg_config; else leave 'pkg-config' pkg-config; fi
if command -v cmake >/dev/null 2>&1; then
    check 'CMake: add_subdirectory' cmake_user "add_subdirectory($root dapple)"
    check 'CMake: FetchContent' cmake_user "include(FetchContent)
FetchContent_Declare(dapple SOURCE_DIR $root)
FetchContent_MakeAvailable(dapple)"
    check 'CMake: a static library with add_subdirectory, exported' exported
    check 'CMake: find_package after make install' cmake_user "find_package(dapple $VERSION REQUIRED)"
    check 'CMake: another major version is refused' refused
    make -s uninstall PREFIX="$dir/there"
    check 'CMake: install' sh -c "cmake -S '$root' -B '$dir/own' -DCMAKE_INSTALL_PREFIX='$dir/there' && cmake --install '$dir/own'"
    check 'CMake: find_package' cmake_user "find_package(dapple $VERSION REQUIRED)"
    find "$dir/there" -type f -exec rm {} +
    make -s install PREFIX="$dir/there"
else leave 'CMake' cmake; fi
check 'make uninstall' uninstalled
if git rev-parse HEAD >/dev/null 2>&1; then
    check 'make dist' from_dist
    check 'make install makes no build folder' fresh
else leave 'make dist' 'git, or a checkout,'; fi
echo "package: $passed passed, $failed failed, $skipped skipped"
[ -n "$TOTALS" ] && echo "$passed $failed $skipped" >> "$TOTALS"
[ $failed = 0 ]
