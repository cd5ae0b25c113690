#!/bin/sh
# core.sh HEADER... - the core of each header, which is what `make join HEADER WITHOUT="all"` writes: it has at most 5,000
# lines, gl_backend.h under 2,500, and gcc and clang compile it in C99 and C++11 with all warnings as errors, functions that nothing calls included.
# gcc compiles the header without each single optional part as well.
# A program made with the whole header and with its core prints the same: tests/LIBRARY/core.c, which writes a file and
# opens it with the core where that cannot build, or bytes.c.
# As many headers are tried side by side as there are processors.
warn='-pedantic -Wall -Wextra -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion -Wundef -Wcast-qual -Wvla -Werror'

fail() { echo "core: FAILED: $1"; [ -s "$here/log" ] && head -n 12 "$here/log"; failed=1; }
# compile_core FILE INCLUDE STANDARD COMPILER [FLAGS]: into $here/program, or syntax alone
compile_core() {
    case $3 in c++11) language=c++ ;; *) language=c ;; esac
    file=$1 include=$2 standard=$3 compiler=$4
    shift 4
    # shellcheck disable=SC2086
    "$compiler" -std="$standard" $warn -Wunused-function -x $language -I"$include" "$file" "$@" > "$here/log" 2>&1
}
# one HEADER: its core, in a folder of its own
one() {
    header=$1 failed=0 name=$(basename "$1" .h)
    here=$dir/$name
    mkdir -p "$here/core/gl_backend"
    ${JOIN:-build/tools/join} --to "$here/core" --without all "$header" > "$here/log" 2>&1 || { fail "$header"; return 1; }
    lines=$(wc -l < "$here/core/$header")
    : > "$here/log"
    case $header in gl_backend/gl_backend.h) most=2499 ;; *) most=5000 ;; esac
    [ "$lines" -le $most ] || fail "$header: its core has $lines lines, more than $most"
    case $header in gl_backend/*) echo "core: $lines lines of $header"; return $failed ;; esac
    printf '#define %s_IMPLEMENTATION\n#include "%s"\n' "$(echo "$name" | tr a-z A-Z)" "$header" > "$here/one.c"
    for compiler in gcc clang; do
        for standard in c99 c++11; do
            compile_core "$here/one.c" "$here/core" $standard $compiler -fsyntax-only || fail "$compiler $standard $header"
        done
    done
    for part in $(sed -n 's/.*optional \([a-z0-9_]*\).*/\1/p' "src/$name/parts.txt" | sort -u); do
        mkdir -p "$here/without_$part"
        ${JOIN:-build/tools/join} --to "$here/without_$part" --without "$part" "$header" > "$here/log" 2>&1 &&
            compile_core "$here/one.c" "$here/without_$part" c99 gcc -fsyntax-only || fail "gcc c99 $header without $part"
    done
    test=tests/$name/bytes.c
    [ -f "tests/$name/core.c" ] && test=tests/$name/core.c
    also=
    if ! cmp -s "$header" "$here/core/$header"; then
        also=", prints what the whole header does: $test"
        for where in . "$here/core"; do
            if ! compile_core "$test" "$where" c99 gcc -O1 -I. -lm -o "$here/program" ||
                ! "$here/program" "$here/file" > "$here/printed$([ "$where" = . ] && echo 0)" 2> "$here/log"; then
                fail "$test with $where/$header"
            fi
        done
        : > "$here/log"
        cmp -s "$here/printed0" "$here/printed" || fail "$test prints something else with the core of $header"
    fi
    echo "core: $lines lines of $header, of $(wc -l < "$header")$also"
    return $failed
}
if [ "$1" = --one ]; then one "$2"; exit; fi

dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
export dir
printf '%s\n' "$@" | xargs -n 1 -P "$(nproc 2>/dev/null || echo 1)" sh "$0" --one
