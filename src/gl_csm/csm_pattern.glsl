// csm_pattern - reads patterns of samples for cohsm_estimate from the table of lights: a texel has two
// points, S points make a pattern.
// uses: csm_access cohsm_math
#ifdef CSM_PATTERNS
// Returns point `at` of all patterns.
vec2 csm_pattern(uint at)
{
    uvec4 t = COHSM_LIGHT_TEXEL(glbk_csm_frame.pattern_texel + (at >> 1));
    return uintBitsToFloat(cohsm_if((at & 1u) != 0u, t.zw, t.xy));
}
#define COHSM_PATTERN(j, k) csm_pattern((j) * glbk_csm_frame.sample_count + (k))
#endif
