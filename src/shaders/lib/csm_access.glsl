// csm_access - what the files cohsm_* ask of a program, from the textures that glbk_csm_bind binds.
// uses: table csm_bindings
#define COHSM_TEXEL(i) texelFetch(glbk_csm_blocks, glbk_table_at(i), 0)
#ifdef CSM_INSTANCES                // 1 or 16: no more instances than that, in the uniform block with their headers
#define COHSM_INSTANCE(table, i, k) glbk_csm_scene.instances[11u * min(i, uint(CSM_INSTANCES) - 1u) + k]
#define COHSM_HEADER(i, k) COHSM_INSTANCE(0u, i, 3u + k)
#endif
#define COHSM_LIGHT_TEXEL(i) texelFetch(glbk_csm_lights, glbk_table_at(i), 0)
#define COHSM_LOBE(i) COHSM_LIGHT_TEXEL(i)
#ifndef COHSM_LOBES
#define COHSM_LOBES 1
#endif

// Two points of a pattern stand in each texel, S points make a pattern.
#ifdef CSM_PATTERNS
vec2 csm_pattern(uint at)
{
    uvec4 t = COHSM_LIGHT_TEXEL(glbk_csm_frame.tables.x + (at >> 1));
    return uintBitsToFloat((at & 1u) != 0u ? t.zw : t.xy);
}
#define COHSM_PATTERN(j, k) csm_pattern((j) * glbk_csm_frame.sampling.x + (k))
#endif
