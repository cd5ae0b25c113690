#!/bin/sh
# join.sh JOIN HEADER... - tests of tools/join, in a copy of src: parts make the header that stands there, an edited header
# goes back into its parts, and what cannot go back or is wrong in a parts.txt is said. Optional parts: lean.sh.
join=$PWD/$1
shift
root=$PWD dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
passed=0 failed=0

check() {       # check NAME COMMAND...
    name=$1
    shift
    if "$@" > "$dir/log" 2>&1; then passed=$((passed + 1))
    else
        echo "  FAILED: $name"
        tail -n 12 "$dir/log"
        failed=$((failed + 1))
    fi
}
fresh() {
    rm -rf "$dir/tree" && mkdir -p "$dir/tree/gl_backend" && cp -r "$root/src" "$dir/tree/src" &&
        for header in "$@"; do cp "$root/$header" "$dir/tree/$header" || return 1; done && cd "$dir/tree"
}
same_everywhere() { "$join" --check "$@"; }
a_difference_is_found() {
    echo '/* one line more */' >> src/csm/order.h
    ! "$join" --check csm.h && "$join" csm.h && "$join" --check csm.h && grep -q 'one line more' csm.h
}
an_edit_goes_back() {
    sed 's|^/\* ==== src/csm/order.h ==== \*/|&\n\n/* mended in the header */|' csm.h > mended/csm.h &&
        "$join" --back mended/csm.h && head -n 1 src/csm/order.h | grep -q 'mended in the header' &&
        "$join" csm.h && cmp csm.h mended/csm.h
}
an_edit_of_a_unit_is_refused() {
    awk '/^\/\* ==== src\/shared\/v3.h/ { print; getline; print; print "/* mine */"; next } { print }' csm.h > mended/csm.h
    cp -r src before && ! "$join" --back mended/csm.h && diff -r src before
}
an_unknown_mark_is_refused() {
    sed 's|^/\* ==== src/csm/order.h|/* ==== src/csm/none.h|' csm.h > mended/csm.h
    ! "$join" --back mended/csm.h
}
an_unknown_header_is_refused() { ! "$join" none.h; }
a_missing_part_is_refused() { echo 'none.h' >> src/csm/parts.txt; ! "$join" csm.h; }
a_part_without_a_last_line_end_is_refused() { printf 'x' >> src/csm/order.h; ! "$join" csm.h; }
a_lean_header_loses_what_nothing_uses() {
    printf '\nstatic int cohsm__of_pack(void) { return cohsm__of_this(); }\n\n' >> src/csm/pack.h
    printf '\nstatic int cohsm__of_this(void) { return 1; }\n' >> src/csm/order.h
    printf '\n#ifdef COHSM_WITHOUT_PACK\nenum { COHSM__LEAN = 1 };\n#else\nenum { COHSM__WHOLE = 1 };\n#endif\n' >> src/csm/order.h
    "$join" csm.h && "$join" --to lean --without pack csm.h && grep -q cohsm__of_this csm.h && ! grep -q cohsm__of_this lean/csm.h &&
        grep -q COHSM__LEAN lean/csm.h && ! grep -q COHSM__WHOLE lean/csm.h && ! grep -q 'ifdef COHSM_WITHOUT' lean/csm.h
}
a_lean_header_loses_its_glsl() {
    mkdir lean/gl_backend && "$join" gl_backend/gl_csm.h && "$join" --to lean --without build gl_backend/gl_csm.h &&
        grep -q 'prog/csm_peel.vert' gl_backend/gl_csm.h && ! grep -q 'csm_peel' lean/gl_backend/gl_csm.h &&
        grep -q 'prog/csm_shade.frag' lean/gl_backend/gl_csm.h && grep -q '^#define GLBK_CSM_WITHOUT_BUILD' lean/gl_backend/gl_csm.h
}
glsl_that_is_not_there_is_refused() { echo 'csm_none.vert optional build' >> src/gl_csm/parts.txt; ! "$join" gl_backend/gl_csm.h; }
a_lean_header_does_not_go_back() { "$join" --to lean --without pack csm.h && cp -r src before && ! "$join" --back lean/csm.h && diff -r src before; }
an_unknown_optional_part_is_refused() { ! "$join" --to lean --without 'pack x86' csm.h; }
lines_name_parts() { mkdir lined && "$join" --lines --to lined csm.h && grep -q '^#line 1 "src/csm/order.h"' lined/csm.h; }

fresh "$@" && check 'every header is what its parts make' same_everywhere "$@"
check 'a part that differs is found and joined' a_difference_is_found
for test in an_edit_goes_back an_edit_of_a_unit_is_refused an_unknown_mark_is_refused an_unknown_header_is_refused \
    a_missing_part_is_refused a_part_without_a_last_line_end_is_refused lines_name_parts \
    a_lean_header_loses_what_nothing_uses a_lean_header_loses_its_glsl glsl_that_is_not_there_is_refused a_lean_header_does_not_go_back an_unknown_optional_part_is_refused; do
    fresh "$@" && mkdir mended lean && check "$(echo $test | tr _ ' ')" $test
done

echo "join: $passed passed, $failed failed, 0 skipped"
[ -n "$TOTALS" ] && echo "$passed $failed 0" >> "$TOTALS"
[ $failed = 0 ]
