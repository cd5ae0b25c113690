// csm_pattern - patterns of samples for cohsm_estimate, from the tables of the frame; two points stand in each texel, S
// points make a pattern.
// uses: csm_access
#ifdef CSM_PATTERNS
vec2 csm_pattern(uint at)
{
    uvec4 t = COHSM_LIGHT_TEXEL(glbk_csm_frame.tables.x + (at >> 1));
    return uintBitsToFloat((at & 1u) != 0u ? t.zw : t.xy);
}
#define COHSM_PATTERN(j, k) csm_pattern((j) * glbk_csm_frame.sampling.x + (k))
#endif
