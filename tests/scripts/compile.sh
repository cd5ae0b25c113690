#!/bin/sh
# check HEADER... - builds every header in every way that a user may: gcc and clang, C99, C11, C++11 and C++20, warnings
# as errors; alone, all together in one file, declarations twice, static mode, implementation in the middle, after
# system headers that make plain words macros; and what must not compile, whose #error is looked for. Each program calls
# a function, so that a missing implementation does not link. Every header has PREFIX_result_text.
# In each compiler's second standard files are read and not translated: what an optimiser or a linker finds does not
# depend on the standard. gcc finds some faults as it optimises, clang none: it optimises C alone, and without intrinsics
# nothing; C++ is optimised by gcc as far as these faults need. g++ and clang read implementations in the middle, which gcc
# links, and clang reads static copies, which gcc and g++ link: it warns of all it knows as it reads, where gcc finds what
# is never called in the end alone. What is static is translated by -O1: by -O0 gcc keeps what nothing calls. tcc, which
# warns of other things, such as a macro that is defined twice, translates each header alone. An implementation that
# several programs link is compiled once.
# As many builds run side by side as there are processors: a list of jobs, each a line "KIND|COMPILER|LANGUAGE|STANDARD|
# FLAGS|WHAT|OUTPUT|FILES|OBJECTS"; programs with objects come after what compiles these.
warn='-pedantic -Wall -Wextra -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion -Wundef -Wcast-qual -Wvla'
warn="$warn -Werror"

# job LINE: one of the list; it prints what is wrong
job() {
    IFS='|' read -r kind compiler language standard flags what output files objects << END
$1
END
    log=$dir/log.$$ status=0 strict=
    [ "$language" = c ] && strict='-Wstrict-prototypes -Wmissing-prototypes'
    set -- -std="$standard" $flags -I. -x "$language" $files
    case $kind in
    read) $compiler $warn $strict -fsyntax-only "$@" > "$log" 2>&1 || status=1 ;;
    object) $compiler $warn $strict -c "$@" -o "$output" > "$log" 2>&1 || status=1 ;;
    program) $compiler $warn $strict "$@" -x none $objects -lm -o "$output" > "$log" 2>&1 && "$output" || status=1 ;;
    # What must not compile, and the text of the #error that it is refused with.
    refused) if $compiler -fsyntax-only "$@" > "$log" 2>&1; then status=1 what="$what compiles"
        elif ! grep -q "error.*$output" "$log"; then status=1 what="$what does not say \"$output\""; fi ;;
    esac
    echo built >> "$dir/counts"
    if [ $status != 0 ]; then
        echo failed >> "$dir/counts"
        { echo "check-compile: FAILED: $compiler $standard $what"; head -n 12 "$log"; } > "$log.text"
        cat "$log.text"
    fi
    rm -f "$log" "$log.text"
}
if [ "$1" = --job ]; then job "$2"; exit 0; fi

dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
export dir

prefix() { sh tools/prefix "$1.h"; }
macro() { basename "$1" | tr a-z A-Z; }
# The function that a program calls: gl_csm.h has glbk_csm_part, gl_wavelets.h glbk__wavelets; all others want a context.
call() {
    units=$(sed -n 's/^units //p' $(grep -lx "header $1.h" src/*/parts.txt))
    [ "$units" != glbk_gbuf ] || units=glbk_gbuffer
    [ "$units" != glbk_prog ] || { echo 'glbk_find_file(NULL, "lib/table.glsl") != NULL'; return; }
    [ "$units" != glbk_haar ] || { echo 'glbk__wavelets() != NULL'; return; }
    if [ -n "$units" ]; then echo "${units}_part() != NULL"; else echo "$(prefix "$1")_result_text(($(prefix "$1")_result)0) != NULL"; fi
}
# Whose implementations a header wants in some file, its own or another one: every gl_*.h that of gl_backend.h, and all but
# gl_programs.h that of gl_programs.h; those of techniques that of gl_gbuffer.h, gl_shadowfield.h that of shadowfield.h,
# and gl_wavelets.h those of both.
under() {
    case $1 in gl_backend/gl_backend) ;; gl_backend/*) echo gl_backend/gl_backend ;; esac
    case $1 in gl_backend/gl_backend | gl_backend/gl_programs) ;; gl_backend/*) echo gl_backend/gl_programs ;; esac
    case $1 in gl_backend/gl_csm | gl_backend/gl_envshadow | gl_backend/gl_rsm | gl_backend/gl_ism) echo gl_backend/gl_gbuffer ;; esac
    case $1 in gl_backend/gl_shadowfield | gl_backend/gl_wavelets) echo gl_backend/gl_gbuffer shadowfield ;; esac
    case $1 in gl_backend/gl_wavelets) echo gl_backend/gl_shadowfield ;; esac
}
implement() { for u in $(under "$1") "$1"; do printf '#define %s_IMPLEMENTATION\n' "$(macro "$u")"; done; }
static() { for u in $(under "$1") "$1"; do macro "$(prefix "$u")"; done | sort -u | sed 's/.*/#define &_STATIC/'; }
# The body of a main() that calls one function of each header named.
calls() {
    printf 'int main(void)\n{\n    int ok = 1;\n'
    for h in "$@"; do printf '    ok = ok && %s;\n' "$(call "$h")"; done
    printf '    return ok ? 0 : 1;\n}\n'
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

line() { printf '%s|%s|%s|%s|%s|%s|%s|%s|%s\n' "$@"; }

# first COMPILER LANGUAGE STANDARD FULL OTHER: translated, by FULL with intrinsics and by OTHER without
first() {
    at=$dir/$1
    mkdir -p "$at/gl_backend"
    case $1 in gcc) whole=program private=program ;; g++) whole=read private=program ;; *) whole=read private=read ;; esac
    line program "$1" "$2" "$3" -O0 'all in one file' "$at/all" "$dir/all.one" '' >> "$dir/jobs"
    for h in $names; do
        off="-DNDEBUG -D$(macro "$(prefix "$h")")_NO_SIMD" with= without=
        for u in $(under "$h") "$h"; do with="$with $at/$u.o" without="$without $at/$u.off.o"; done
        {
            line object "$1" "$2" "$3" "$4" "$h alone" "$at/$h.o" "$dir/$h.impl" ''
            line object "$1" "$2" "$3" "$5 $off" "$h alone, NDEBUG, no intrinsics" "$at/$h.off.o" "$dir/$h.impl" ''
            line $private "$1" "$2" "$3" -O1 "$h static" "$at/$h.static" "$dir/$h.static" ''
            line $whole "$1" "$2" "$3" -O0 "$h implementation in the middle" "$at/$h.middle" "$dir/$h.middle" ''
            line read "$1" "$2" "$3" '' "$h after windows.h and Xlib.h" '' "$dir/$h.windows" ''
        } >> "$dir/jobs"
        {
            line program "$1" "$2" "$3" '' "$h alone" "$at/$h.use" "$dir/$h.use" "$with"
            line program "$1" "$2" "$3" "$off" "$h alone, NDEBUG, no intrinsics" "$at/$h.off" "$dir/$h.use" "$without"
            [ $private = read ] || line program "$1" "$2" "$3" -O1 "$h beside a static copy without intrinsics" "$at/$h.both" \
                "$dir/$h.other $dir/$h.both" "$with"
        } >> "$dir/links"
    done
}
# second COMPILER LANGUAGE STANDARD: read only; which functions are static, the order of includes, and plain words that are
# macros, are the same in both
second() {
    line read "$1" "$2" "$3" '' 'all in one file' '' "$dir/all.one" '' >> "$dir/jobs"
    for h in $names; do
        off="-DNDEBUG -D$(macro "$(prefix "$h")")_NO_SIMD"
        line read "$1" "$2" "$3" '' "$h alone" '' "$dir/$h.impl $dir/$h.use" ''
        line read "$1" "$2" "$3" "$off" "$h alone, NDEBUG, no intrinsics" '' "$dir/$h.impl $dir/$h.use" ''
    done >> "$dir/jobs"
}
# Old languages, and private functions without their bodies.
refusals() {
    for h in $names; do
        { static "$h"; printf '#include "%s.h"\n' "$h"; calls "$h"; } > "$dir/$h.bare"
        line refused "$1" c c90 '' "$h" 'needs C99 or C++11' "$dir/$h.use" ''
        line refused "$1" c c99 '' "$h" 'STATIC makes .*private' "$dir/$h.bare" ''
    done >> "$dir/jobs"
}
have() {
    command -v "$1" >/dev/null 2>&1 && return
    echo "check-compile: skipped: $1 (not installed)"
    [ -z "$CI" ] || echo failed >> "$dir/counts"
    return 1
}

: > "$dir/counts"
if have g++; then first g++ c++ c++11 -O1 -O0; second g++ c++ c++20; fi
if have gcc; then first gcc c c99 -O2 -O1; second gcc c c11; refusals gcc; fi
if have tcc; then
    mkdir -p "$dir/tcc/gl_backend"
    for h in $names; do line object tcc c c99 '' "$h alone" "$dir/tcc/$h.o" "$dir/$h.impl" ''; done >> "$dir/jobs"
fi
if have clang; then first clang c c99 -O2 -O0; second clang c c11; refusals clang; fi
if have clang++; then first clang++ c++ c++11 -O0 -O0; second clang++ c++ c++20; fi
for list in jobs links; do xargs -d '\n' -n 1 -P "$(nproc 2>/dev/null || echo 1)" sh "$0" --job < "$dir/$list"; done
failed=$(grep -c failed "$dir/counts")
echo "check-compile: $(grep -c built "$dir/counts") builds, $failed failed"
[ "$failed" = 0 ]
