#!/bin/sh
# size HEADER... - what a program carries that needs only one technique on the GPU: every public function of one gl_*.h, of
# gl_backend.h and gl_programs.h, their GLSL included, is linked with the implementations of all headers by -Os and
# --gc-sections, and stripped. The difference to an empty program must stay below 150,000 bytes, with what the header calls
# of its technique's, and of gl_gbuffer.h and, for gl_wavelets.h, of gl_shadowfield.h (which have lines of their own with all
# that they can). The linker is told the names
# (-u) in place of a program that has their addresses, since a table of these takes 32 bytes a name, which no header does.
CC=${CC:-gcc}
limit=150000
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
flags='-std=c99 -Os -ffunction-sections -fdata-sections -I.'
failed=0 objects=

if ! echo 'int main(void) { return 0; }' | $CC -x c - -Wl,--gc-sections -o "$dir/empty" 2>/dev/null; then
    echo "check-size: skipped: the linker of $CC has no --gc-sections"
    exit 0
fi
# The headers of gl_backend/ that a header includes, one way or another.
below() {
    sed -n 's/^#include "\(gl_[a-z]*\.h\)"$/\1/p' "$1" | while read -r name; do
        echo "gl_backend/$name"
        below "gl_backend/$name"
    done | sort -u
}
strip "$dir/empty"
empty=$(wc -c < "$dir/empty")
for header in "$@"; do
    name=$(basename "$header" .h)
    printf '#define %s_IMPLEMENTATION\n#include "%s"\n' "$(echo "$name" | tr a-z A-Z)" "$header" > "$dir/$name.c"
    # shellcheck disable=SC2086
    $CC $flags -c "$dir/$name.c" -o "$dir/$name.o" || exit 1
    objects="$objects $dir/$name.o"
done
for header in "$@"; do
    case $header in gl_backend/gl_backend.h) continue ;; gl_backend/*) ;; *) continue ;; esac
    # shellcheck disable=SC2046
    names=$(sed -n 's/^GLBK_DEF [^(]*[ *]\(glbk_[a-z0-9_]*\)(.*/\1/p' $(below "$header" | grep -v 'gl_gbuffer\|gl_shadowfield') "$header" |
        grep -v __ | sort -u | sed 's/^/-Wl,-u,/')
    # shellcheck disable=SC2086
    echo 'int main(void) { return 0; }' | $CC -x c - -x none $objects $names -Wl,--gc-sections -lm -o "$dir/program" || exit 1
    # Of other techniques nothing is left: no symbol, no GLSL; of this one every function is there.
    wanted=$(sed -n 's/^units //p' $(grep -lx "header $header" src/*/parts.txt))
    case $header in gl_backend/gl_wavelets.h) wanted=glbk_sfield ;; esac
    strange=$(nm "$dir/program" | sed -n 's/.* \(glbk__\{0,1\}[a-z]*_\).*/\1/p' | sort -u |
        grep -x 'glbk__\{0,1\}\(csm\|sfield\|envsh\|rsm\|ism\)_' | grep -vx "glbk__\{0,1\}${wanted#glbk_}_")
    missing=$(nm "$dir/program" | sed -n 's/.* T /-Wl,-u,/p' > "$dir/linked"; echo "$names" | grep -vxF -f "$dir/linked")
    strip "$dir/program"
    bytes=$(($(wc -c < "$dir/program") - empty))
    echo "check-size: $header: $bytes bytes"
    [ -z "$strange" ] || { echo "check-size: FAILED: $header links" $strange; failed=1; }
    [ -z "$missing" ] || { echo "check-size: FAILED: $header leaves out" $missing; failed=1; }
    [ "$bytes" -lt $limit ] || { echo "check-size: FAILED: $header: more than $limit bytes"; failed=1; }
done
exit $failed
