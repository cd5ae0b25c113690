#!/bin/sh
# check HEADER... - builds every header in every way that a user may: gcc and clang, C99, C11, C++11 and C++20, warnings
# as errors; alone, all together in one file, declarations twice, static mode, implementation in the middle, after
# system headers that make plain words macros; and what must not compile, whose #error is looked for. Each program calls
# a function, so that a missing implementation does not link. Every header has PREFIX_result_text.
# In each compiler's second standard files are read and not translated, but for all headers in one file: what an
# optimiser or a linker finds does not depend on the standard. The two compilers run side by side.
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
root=$(pwd)
warn='-pedantic -Wall -Wextra -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion -Wundef -Wcast-qual -Wvla'
warn="$warn -Werror"

prefix() { sh tools/prefix "$1.h"; }
macro() { basename "$1" | tr a-z A-Z; }
# The function that a program calls: gl_csm.h has glbk_csm_part, its other functions want a context.
call() {
    units=$(sed -n 's/^units //p' $(grep -lx "header $1.h" src/*/parts.txt))
    [ "$units" != glbk_gbuf ] || units=glbk_gbuffer
    [ "$units" != glbk_prog ] || { echo 'glbk_find_file(NULL, "lib/table.glsl") != NULL'; return; }
    if [ -n "$units" ]; then echo "${units}_part() != NULL"; else echo "$(prefix "$1")_result_text(($(prefix "$1")_result)0) != NULL"; fi
}
# Whose implementations a header wants in some file, its own or another one: every gl_*.h that of gl_backend.h, and all but
# gl_programs.h that of gl_programs.h; those of techniques that of gl_gbuffer.h, and gl_shadowfield.h that of shadowfield.h.
under() {
    case $1 in gl_backend/gl_backend) ;; gl_backend/*) echo gl_backend/gl_backend ;; esac
    case $1 in gl_backend/gl_backend | gl_backend/gl_programs) ;; gl_backend/*) echo gl_backend/gl_programs ;; esac
    case $1 in gl_backend/gl_csm | gl_backend/gl_envshadow | gl_backend/gl_rsm | gl_backend/gl_ism) echo gl_backend/gl_gbuffer ;; esac
    case $1 in gl_backend/gl_shadowfield) echo gl_backend/gl_gbuffer shadowfield ;; esac
}
implement() { for u in $(under "$1") "$1"; do printf '#define %s_IMPLEMENTATION\n' "$(macro "$u")"; done; }
static() { for u in $(under "$1") "$1"; do macro "$(prefix "$u")"; done | sort -u | sed 's/.*/#define &_STATIC/'; }
# The body of a main() that calls one function of each header named.
calls() {
    printf 'int main(void)\n{\n    int ok = 1;\n'
    for h in "$@"; do printf '    ok = ok && %s;\n' "$(call "$h")"; done
    printf '    return ok ? 0 : 1;\n}\n'
}

# build WHAT FLAGS FILE...: as C or C++ by $std, with $compiler; what was made is run
build() {
    what=$1 flags=$2 program=$dir/$job output="-lm -o $dir/$job"
    case $flags in *-fsyntax-only*) program=true output= ;; esac
    shift 2
    echo built >> "$dir/counts"
    # shellcheck disable=SC2086
    if ! $compiler -std=$std $warn $strict $flags -I"$root" -x $language "$@" $output > "$dir/$job.log" 2>&1 ||
        ! "$program"; then
        echo failed >> "$dir/counts"
        { echo "check-compile: FAILED: $compiler $std $what"; head -n 12 "$dir/$job.log"; } > "$dir/$job.text"
        cat "$dir/$job.text"
    fi
}

names=
for header in "$@"; do names="$names ${header%.h}"; done

mkdir -p "$dir/gl_backend"
for h in $names; do
    printf '#define %s_IMPLEMENTATION\n#include "%s.h"\n' "$(macro "$h")" "$h" > "$dir/$h.impl"
    { printf '#include "%s.h"\n#include "%s.h"\n' "$h" "$h"; calls "$h"; } > "$dir/$h.use"
    { static "$h"; implement "$h"; printf '#include "%s.h"\n' "$h"; calls "$h"; } > "$dir/$h.static"
    { printf '#include "%s.h"\n' "$h"; calls "$h"
      implement "$h"; printf '#include "%s.h"\n' "$h"
      printf '#include "%s.h"\nextern int after;\nint after = %s_VERSION;\n' "$h" "$(macro "$(prefix "$h")")"
    } > "$dir/$h.middle"
    { static "$h"; printf '#define %s_NO_SIMD\n' "$(macro "$(prefix "$h")")"; implement "$h"
      printf '#include "%s.h"\nint other(void);\nint other(void) { return %s; }\n' "$h" "$(call "$h")"
    } > "$dir/$h.other"
    # windows.h and Xlib.h make plain words macros
    { printf '#include <%s.h>\n' float limits math stdarg stddef stdint stdio stdlib string
      printf '#if defined(__x86_64__)\n#include <immintrin.h>\n#endif\n'
      printf '#define %s\n' near far NEAR FAR pascal cdecl IN OUT OPTIONAL 'CONST const' 'small char' 'hyper long' \
          'interface struct' 'min(a, b) ((a) < (b) ? (a) : (b))' 'max(a, b) ((a) > (b) ? (a) : (b))' 'ERROR 0' \
          'OPAQUE 2' 'TRANSPARENT 1' 'ABSOLUTE 1' 'RELATIVE 2' 'None 0L' 'Bool int' 'Status int' 'True 1' 'False 0' \
          'Success 0' 'Always 2' 'Above 0' 'Below 1' 'Complex 0' 'Convex 2'
      implement "$h"; printf '#include "%s.h"\n' "$h"; calls "$h"
    } > "$dir/$h.windows"
    { printf '#include "%s.h"\nint other(void);\n' "$h"; calls "$h" | sed 's/ok = 1;/ok = other();/'; } > "$dir/$h.both"
done
for h in $names; do printf '#define %s_IMPLEMENTATION\n' "$(macro "$h")"; done > "$dir/all.one"
for h in $names; do printf '#include "%s.h"\n' "$h"; done >> "$dir/all.one"
# shellcheck disable=SC2086
calls $names >> "$dir/all.one"

# matrix COMPILER LANGUAGE STANDARD...
matrix() {
    compiler=$1 language=$2 job=$1 strict=
    shift 2
    if ! command -v "$compiler" >/dev/null 2>&1; then
        echo "check-compile: skipped: $compiler (not installed)"
        [ -n "$CI" ] && echo failed >> "$dir/counts"
        return
    fi
    [ "$language" = c ] && strict='-Wstrict-prototypes -Wmissing-prototypes'
    for std in "$@"; do
        full=-fsyntax-only other=-fsyntax-only none=-fsyntax-only
        [ "$std" = "$1" ] && full=-O2 other=-O1 none=-O0
        for h in $names; do
            off="-DNDEBUG -D$(macro "$(prefix "$h")")_NO_SIMD"
            impl=$dir/$h.impl
            for u in $(under "$h"); do impl="$impl $dir/$u.impl"; done
            # shellcheck disable=SC2086
            build "$h alone" $full $impl "$dir/$h.use"
            # shellcheck disable=SC2086
            build "$h alone, NDEBUG, no intrinsics" "$other $off" $impl "$dir/$h.use"
            build "$h static" $none "$dir/$h.static"
            # shellcheck disable=SC2086
            build "$h beside a static copy without intrinsics" $none $impl "$dir/$h.other" "$dir/$h.both"
            build "$h implementation in the middle" $none "$dir/$h.middle"
            build "$h after windows.h and Xlib.h" -fsyntax-only "$dir/$h.windows"
        done
        build 'all in one file' -O0 "$dir/all.one"
    done
}

# refused HEADER COMPILER LANGUAGE STANDARD TEXT FILE: does not compile, and the compiler prints the #error with this text
refused() {
    echo built >> "$dir/counts"
    if "$2" -std="$4" -I"$root" -x "$3" -fsyntax-only "$6" > "$dir/refused.log" 2>&1; then reason='compiles'
    elif grep -q "error.*$5" "$dir/refused.log"; then return
    else reason="does not say \"$5\""
    fi
    echo failed >> "$dir/counts"
    { echo "check-compile: FAILED: $2 $4 $1 $reason"; head -n 4 "$dir/refused.log"; }
}

# Old languages, and private functions without their bodies.
refusals() {
    for h in $names; do
        { static "$h"; printf '#include "%s.h"\n' "$h"; calls "$h"; } > "$dir/$h.bare"
        for compiler in gcc clang; do
            command -v $compiler >/dev/null 2>&1 || continue
            refused "$h" $compiler c c90 'needs C99 or C++11' "$dir/$h.use"
            refused "$h" $compiler c c99 'STATIC makes .*private' "$dir/$h.bare"
        done
    done
}

: > "$dir/counts"
refusals
(matrix gcc c c99 c11; matrix g++ c++ c++11 c++20) &
(matrix clang c c99 c11; matrix clang++ c++ c++11 c++20) &
wait
failed=$(grep -c failed "$dir/counts")
echo "check-compile: $(grep -c built "$dir/counts") builds, $failed failed"
[ "$failed" = 0 ]
