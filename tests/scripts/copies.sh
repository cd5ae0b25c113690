#!/bin/sh
# copies.sh HEADER... - what README.md tells to copy is enough, and no more than that: each header of the top level alone, and
# each row of the table of OpenGL, in an empty folder. The Quick start of the header, of a row its last one in gl_backend/, is
# linked there as C99 and read as C++11; without any single file of a row it must not compile. A renamed header that would
# include the one of another version in place of itself does not compile either, but does when X_FILE names it.
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
warn='-pedantic -Wall -Wextra -Werror'
failed=0 count=0

# copied HEADER FILE...: the Quick start of HEADER with these files
copied() {
    header=$1
    shift
    rm -rf "$dir/user" && mkdir -p "$dir/user/gl_backend" || exit 1
    sh tools/quick-start "$header" > "$dir/user/main.c"
    for file; do
        cp "$file" "$dir/user/$file" || { echo "check-readme: README.md names $file, which is not there"; failed=1; return; }
    done
    count=$((count + 1))
    (
        cd "$dir/user" || exit 1
        # shellcheck disable=SC2086
        ${CC:-cc} -std=c99 $warn -I. main.c -lm -o main && ${CXX:-c++} -std=c++11 $warn -I. -fsyntax-only -x c++ main.c || exit 1
        [ $# = 1 ] || for file; do          # of a single one that is clear
            mv "$file" taken
            ! ${CC:-cc} -std=c99 -I. -fsyntax-only main.c 2>/dev/null ||
                { echo "check-readme: README.md names $file for $header, which compiles without"; exit 1; }
            mv taken "$file"
        done
    ) > "$dir/log" 2>&1 && return
    echo "check-readme: FAILED: $header with what README.md names: $*"
    head -n 12 "$dir/log"
    failed=1
}

# renamed HEADER: where the header includes itself
renamed() {
    own=$(sed -n 's/^#define \([A-Z]*\)_FILE "[a-z]*\.h"$/\1/p' "$1")
    [ -n "$own" ] || return 0
    rm -rf "$dir/user" && mkdir "$dir/user" || exit 1
    cp "$1" "$dir/user/renamed.h"
    sed "/${own}_VERSION/s/[0-9][0-9]*/999/" "$1" > "$dir/user/$1"
    printf '#define %s_IMPLEMENTATION\n#include "renamed.h"\n' "$(basename "$1" .h | tr a-z A-Z)" > "$dir/user/main.c"
    count=$((count + 1))
    (
        cd "$dir/user" || exit 1
        ! ${CC:-cc} -std=c99 -I. -fsyntax-only main.c 2> errors && grep "$1.*of another version" errors &&
            ${CC:-cc} -std=c99 -I. -fsyntax-only "-D${own}_FILE=\"renamed.h\"" main.c
    ) > "$dir/log" 2>&1 && return
    echo "check-readme: FAILED: a renamed $1"
    head -n 12 "$dir/log"
    failed=1
}

for header; do
    case $header in
    gl_backend/gl_backend.h) ;;         # it stands in every row, and last in none
    gl_backend/*) grep -q "^  | .* | [^|]*$(basename "$header") | " README.md ||
        { echo "check-readme: no row of README.md ends with $header"; failed=1; } ;;
    *) copied "$header" "$header"; renamed "$header" ;;
    esac
done
sed -n 's/^  | [^|]* | \(gl_backend\.h[^|]*\)| \([^|]*\)|$/\1|\2/p' README.md > "$dir/rows"
while IFS='|' read -r inside beside; do
    files=
    for file in $inside; do files="$files gl_backend/$file" header=gl_backend/$file; done
    # shellcheck disable=SC2086
    copied "$header" $files $beside
done < "$dir/rows"
[ $failed = 0 ] && echo "check-readme: $count copies are enough"
exit $failed
