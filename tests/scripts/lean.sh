#!/bin/sh
# lean.sh - headers without their optional parts: each tests/LIBRARY/lean_PARTS.c is compiled with LIBRARY.h as it is and as
# `make join LIBRARY.h WITHOUT="PARTS"` writes it (several parts: joined by _), by gcc in C99, which optimises, and by clang in
# C++11, with all warnings as errors. All of these programs exit with 0 and print the same. As many compilers run side by side as there are
# processors; tests that differ in their comment alone share the program with the whole header.
warn='-pedantic -Wall -Wextra -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion -Wundef -Wcast-qual -Wvla'

# run TEST FOLDER NAME: the program with the header of this folder, and what it prints
run() {
    echo built >> "$dir/counts"
    # shellcheck disable=SC2086
    $compiler $optimise -std="$standard" $warn -Werror -D"$own"_STATIC= -x $language -I"$2" "$1" -lm -o "$here/program" > "$here/log" 2>&1 &&
        "$here/program" > "$here/$3" && return
    echo "lean: FAILED: $compiler $standard $1 with $2/$library.h"
    head -n 12 "$here/log"
    return 1
}
# all LIBRARY COMPILER STANDARD: every test of a library
all() {
    library=$1 compiler=$2 standard=$3 here=$dir/$$ status=0 last=
    case $standard in c++11) language=c++ optimise=-O0 ;; *) language=c optimise=-O1 ;; esac
    mkdir "$here"
    own=$(sh tools/prefix "$library.h" | tr a-z A-Z)        # a private copy: what the test calls alone
    for test in tests/"$library"/lean_*.c; do
        text=$(grep -v '^/\*.*\*/$' "$test")
        [ "$text" = "$last" ] || run "$test" . whole || return 1
        last=$text
        run "$test" "$dir/$library/$(basename "$test" .c)" lean || { status=1; continue; }
        cmp -s "$here/whole" "$here/lean" || { echo "lean: FAILED: $compiler $standard $test: other results"; status=1; }
    done
    return $status
}
if [ "$1" = --all ]; then all "$2" "$3" "$4"; exit; fi

dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
export dir
for test in tests/*/lean_*.c; do
    name=$(basename "$test" .c) library=$(basename "$(dirname "$test")")
    mkdir -p "$dir/$library/$name"
    ${JOIN:-build/tools/join} --to "$dir/$library/$name" --without "$(echo "${name#lean_}" | tr _ ' ')" "$library.h" \
        > "$dir/log" 2>&1 || { cat "$dir/log"; exit 1; }
done
for library in $(ls tests/*/lean_*.c | xargs -n 1 dirname | xargs -n 1 basename | sort -u); do
    echo "$library gcc c99"
    echo "$library clang c++11"
done | xargs -L 1 -P "$(nproc 2>/dev/null || echo 1)" sh "$0" --all || exit 1
echo "lean: $(grep -c built "$dir/counts") programs"
