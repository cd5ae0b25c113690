#!/bin/sh
# core.sh HEADER... - the core of each header, which is what `make join HEADER WITHOUT="all"` writes: it has at most 5,000
# lines, gl_backend.h under 2,500, and gcc and clang compile it in C99 and C++11 with all warnings as errors, functions that nothing calls included.
# gcc compiles the header without each single optional part as well.
# A program made with the whole header and with its core prints the same: tests/LIBRARY/core.c, which writes a file and
# opens it with the core where that cannot build, or bytes.c.
# A header of gl_backend/ with optional parts is compiled so together with its technique's header without those of the same
# names that it has, and linked; the GLSL that is left is that of the whole header, text by text.
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
# with_technique HEADER PARTS: the lean header of gl_backend/ beside its technique's, without the same parts where it has such
with_technique() {
    technique=${name#gl_}.h
    tree=$here/tree
    mkdir -p "$tree/gl_backend" "$tree/tools"
    cp ./*.h "$tree" && cp gl_backend/*.h "$tree/gl_backend" && cp tools/glsl.c "$tree/tools" &&
        ${JOIN:-build/tools/join} --to "$tree" --without "$2" "$1" > "$here/log" 2>&1 || { fail "$1 without $2"; return; }
    shared=
    for part in $2; do grep -q "optional $part" "src/${technique%.h}/parts.txt" && shared="$shared $part"; done
    if [ -n "$shared" ]; then
        ${JOIN:-build/tools/join} --to "$tree" --without "$shared" "$technique" > "$here/log" 2>&1 || { fail "$technique without$shared"; return; }
    fi
    # The manual's program has all the implementations; without GL it says so and exits with 0.
    awk '/^   Quick start/ { on = 1; next } on && /^   [^ ]/ { exit } on { sub(/^       /, ""); sub(/ \/\/ .*/, ""); print }' "$1" > "$here/start.c"
    for compiler in gcc clang; do
        for standard in c99 c++11; do
            compile_core "$here/start.c" "$tree" $standard $compiler -fsyntax-only || fail "$compiler $standard $1 with $technique, without $2"
        done
    done
    compile_core "$here/start.c" "$tree" c99 gcc -lm -o "$here/program" && "$here/program" > "$here/log" || fail "$1 with $technique, without $2"
    mkdir -p "$here/texts" "$here/lean"
    compile_core "$tree/tools/glsl.c" "$tree" c99 gcc -lm -o "$here/glsl" && "$here/glsl" "$here/lean" 2> "$here/log" &&
        ${GLSL:-build/tools/glsl} "$here/texts" || { fail "the GLSL of $1 without $2"; return; }
    rm "$here/lean/layout"
    for text in "$here/lean"/*; do
        cmp "$text" "$here/texts/$(basename "$text")" > "$here/log" 2>&1 || fail "GLSL of $1 without $2: $(basename "$text") is another"
    done
    also=", and with $technique without $2: $(ls "$here/lean" | wc -l) of $(ls "$here/texts" | wc -l) texts of GLSL, the same"
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
    parts=$(sed -n 's/.*optional \([a-z0-9_]*\).*/\1/p' "src/$name/parts.txt" 2> /dev/null | sort -u)
    also=
    case $header in
    gl_backend/*)
        # shellcheck disable=SC2086
        [ -n "$parts" ] && with_technique "$header" "$(echo $parts)"
        echo "core: $lines lines of $header$also"
        return $failed
        ;;
    esac
    printf '#define %s_IMPLEMENTATION\n#include "%s"\n' "$(echo "$name" | tr a-z A-Z)" "$header" > "$here/one.c"
    for compiler in gcc clang; do
        for standard in c99 c++11; do
            compile_core "$here/one.c" "$here/core" $standard $compiler -fsyntax-only || fail "$compiler $standard $header"
        done
    done
    for part in $parts; do
        mkdir -p "$here/without_$part"
        ${JOIN:-build/tools/join} --to "$here/without_$part" --without "$part" "$header" > "$here/log" 2>&1 &&
            compile_core "$here/one.c" "$here/without_$part" c99 gcc -fsyntax-only || fail "gcc c99 $header without $part"
    done
    test=tests/$name/bytes.c
    [ -f "tests/$name/core.c" ] && test=tests/$name/core.c
    if ! cmp -s "$header" "$here/core/$header"; then
        own=$(sh tools/prefix "$header" | tr a-z A-Z)
        also=", prints what the whole header does: $test"
        for where in . "$here/core"; do
            if ! compile_core "$test" "$where" c99 gcc -O1 -D"$own"_STATIC= -I. -lm -o "$here/program" ||
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
