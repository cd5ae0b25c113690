// rsm_access - reads what the files rsm_* ask of a program from what glbk_rsm_bind binds.
// uses: rsm_bindings rsm_map
// RSM_TEXEL reads image k of texel t.xy of face t.z: 0 has position and depth, 1 normal and material, 2 flux
// and area.
#define RSM_TEXEL(t, k) texelFetch(glbk_rsm_texels, ivec3((t).xy, 3 * (t).z + (k)), 0)
// These read running sums of flux: along a row up to texel x, and over the rows of a face up to row y.
#define RSM_ROW_SUM(t) uintBitsToFloat(texelFetch(glbk_rsm_sums, t, 0).x)
#define RSM_ROWS_SUM(y, face) uintBitsToFloat(texelFetch(glbk_rsm_rows, ivec3(y, 0, face), 0).x)
// RSM_LISTED reads image k of light i of the list: 0 has position and bound, 1 normal and density (MIXED) or
// the squared distance that counts as near, 2 flux and texel, 3 light and material.
#define RSM_LISTED(i, k) texelFetch(glbk_rsm_lights, ivec3(int((i) & 1023u), int((i) >> 10), k), 0)
#define RSM_PATTERN(i) texelFetch(glbk_rsm_pattern, ivec2(int((i) & 1023u), int((i) >> 10)), 0).xyz
#ifndef RSM_LIGHT           // lib/rsm_chunk.glsl defines both
#define RSM_LIGHT(i, k) RSM_LISTED(i, k)
#define RSM_POINT_AT(i) RSM_PATTERN(i)
#endif
#define RSM_MATERIAL(i) texelFetch(glbk_rsm_materials, ivec2(int(i), 0), 0)
