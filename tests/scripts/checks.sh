#!/bin/sh
# checks.sh - faults that the tools/check-... must notice: each is put by sed into a copy of one file, and what the tool
# prints must have the text behind the last bar. A line: tool | file | sed | text.
root=$PWD dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
passed=0 failed=0

mkdir "$dir/tree" "$dir/tree/gl_backend"
tar cf - tools README.md docs/conformance.md src tests/shared -- *.h gl_backend/*.h | (cd "$dir/tree" && tar xf -)
cd "$dir/tree" || exit 1

fail() { printf '  FAILED: %s\n' "$1"; failed=$((failed + 1)); }
noticed() {     # noticed TOOL FILE SED TEXT
    sed -i "$3" "$2"
    if cmp -s "$root/$2" "$2"; then fail "$2: nothing is changed by $3"
    elif said=$(sh "tools/$1" "$2" 2>&1); then fail "$1 does not notice in $2: $3"
    else case $said in *"$4"*) passed=$((passed + 1)) ;; *) fail "$1 in $2: $3 is not called '$4' but $said" ;; esac
    fi
    cp "$root/$2" "$2"
}
while IFS='|' read -r tool file expression text; do
    case $tool in '' | '#'*) continue ;; esac
    noticed "${tool% }" "$(echo $file)" "${expression# }" "${text# }"
done << 'END'
check-papers | rsm.h | s/rsm_gather_desc (offset)/rsm_gather_desc (offsets)/| rsm_gather_desc has no offsets
check-papers | rsm.h | s/rsm_pattern (POISSON)/rsm_pattern (POISON)/| rsm_pattern has no POISON
check-papers | rsm.h | s/rsm_mesh (tap_side)/rsm_points (tap_side)/| rsm_points has no tap_side
check-papers | envshadow.h | s/rgba of envsh_maps_desc/rgb of envsh_maps_desc/| envsh_maps_desc has no rgb
check-papers | csm.h | s/entities of     T62/entity of       T62/| cohsm_query has no entity
check-papers | rsm.h | s/\(rsm_light_kind  *\)T30 T37/\1/| entries with neither rows nor -
check-papers | rsm.h | s/\(rsm_light_kind  *\)T30 T37/\1T5/| its table names T5, which has no test of rsm
check-papers | gl_backend/gl_rsm.h | s/rsm_gloss  /rsm_glass  /| its table names rsm_glass
check-papers | csm.h | s/^  *furnace$/ mirror/| entries with neither rows nor -
check-papers | envlights.h | s/T15 irradiance/T15 furnace/| its table names furnace, which has no test of envlights
check-papers | ism.h | s/From the paper to the code/From the paper/| has no table
check-papers | rsm.h | s/every_pattern_sums_its_samples/each_pattern_sums_its_samples/| its manual names each_pattern_sums_its_samples
check-page-one | rsm.h | s/---- page one: /---- page 1: /| has no /* ---- page one
check-page-one | csm.h | s/^struct cohsm_mesh;.*/&\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n/| more than 60
check-page-one | csm.h | s/^\(COHSM_DEF .*\)cohsm_visible(/\1cohsm_visible_from(/| does not declare its main call
check-page-one | rsm.h | s/^RSM_DEF rsm_result rsm_finish/\/* ---- more ---- *\/\n&/| has 2 calls, not 4 to 7
check-page-one | gifilter.h | s/^GIFILT_DEF void gifilt_reset/GIFILT_DEF void gifilt_a(void);\n&/;s/^GIFILT_DEF void gifilt_a.*/&\n&\n&\n&/| has 11 calls
check-page-one | ism.h | s/^\/\* ---- page one/typedef int ism_early;\n&/| declares something before page one
check-limits | src/shared/rng.h | $a static int long_one(void)\n{\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n}| long_one has 61 lines
check-limits | src/shared/rng.h | $a static int deep(int a)\n{\n                    if (a) a = 1;\n    return a;\n}| deep has a statement in more than four others
check-limits | src/shared/rng.h | $a static int deep(int a)\n{\n            if (a)\n                for (;;) while (a) a--;\n    return a;\n}| deep has a statement in more than four others
check-limits | src/shared/rng.h | $a static int many(int a, int b, int c, int d,\n                int e, int f, int g, int h, int i);| many has more than 8 parameters
check-limits | src/shared/rng.h | $a #define P_LONG(a) \\\n    a \\\n    a \\\n    a \\\n    a \\\n    a \\\n    a \\\n    a \\\n    a \\\n    a \\\n    a| P_LONG has 11 lines
check-limits | src/shared/rng.h | $a static int names(void)\n{\n    int a, b[3], c = 1, *d, e;\n}| more than four names
check-limits | src/gl/passes.h | s/ClearBufferfv(GLBK_GL_DEPTH/ClearBufferfv(0x1801/| 0x1801 without its name
check-limits | src/rsm/flux.h | 59,$d| src/rsm/flux.h: 58 lines, less than 60
check-limits | src/csm/query.h | G| lines, more than 500
check-limits | tests/shared/units_test.c | $a static void test_that_bits_count(void **state)\n{\n}| test_that_bits_count is no sentence
check-limits | tests/shared/units_test.c | $a static void t65_t66_hilbert_curves(void **state)\n{\n}| t65_t66_hilbert_curves is no sentence
check-limits | src/gl_ism/arguments.h | $a static void set(void)\n{\n    values.limits[3] = 1;\n}| by its place
END

echo "checks: $passed passed, $failed failed, 0 skipped"
[ -n "$TOTALS" ] && echo "$passed $failed 0" >> "$TOTALS"
[ $failed = 0 ]
