#!/bin/sh
# lean.sh - headers without their optional parts: each tests/LIBRARY/lean_PARTS.c is compiled with LIBRARY.h as it is and as
# `make join LIBRARY.h WITHOUT="PARTS"` writes it (several parts: joined by _), by gcc and clang, in C99 and C++11, with all
# warnings as errors. All of these programs exit with 0 and print the same.
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
warn='-pedantic -Wall -Wextra -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion -Wundef -Wcast-qual -Wvla'
failed=0
count=0
for test in tests/*/lean_*.c; do
    header=$(basename "$(dirname "$test")").h
    without=$(basename "$test" .c | sed 's/^lean_//; s/_/ /g')
    mkdir -p "$dir/lean"
    ${JOIN:-build/tools/join} --to "$dir/lean" --without "$without" "$header" > "$dir/log" 2>&1 ||
        { cat "$dir/log"; exit 1; }
    for compiler in gcc clang; do
        for standard in c99 c++11; do
            case $standard in c++11) language=c++ ;; *) language=c ;; esac
            for where in . "$dir/lean"; do
                count=$((count + 1))
                # shellcheck disable=SC2086
                if ! $compiler -O1 -std=$standard $warn -Werror -x $language -I"$where" "$test" -lm -o "$dir/program" > "$dir/log" 2>&1 ||
                    ! "$dir/program" > "$dir/printed"; then
                    echo "lean: FAILED: $compiler $standard $test with $where/$header"
                    head -n 12 "$dir/log"
                    failed=1
                    continue
                fi
                [ "$where" = . ] && cp "$dir/printed" "$dir/whole"
            done
            cmp -s "$dir/whole" "$dir/printed" || { echo "lean: FAILED: $compiler $standard $test: other results"; failed=1; }
        done
    done
done
[ $failed = 0 ] && echo "lean: $count programs"
exit $failed
