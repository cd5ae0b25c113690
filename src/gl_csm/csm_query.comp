// Does what csm_query.frag does, as a compute shader over storage buffers.
// uses: csm_visible
// sets: CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=1 CSM_INSTANCES=1
// sets: CSM_ASK=1 CSM_FILTER=2 | CSM_ASK=2 CSM_FILTER=1
// sets: CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=2 CSM_INSTANCES=1
// sets: CSM_ASK=0 CSM_FILTER=1 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=1 CSM_INSTANCES=1
// sets: CSM_ASK=0 CSM_FILTER=1 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=2 CSM_INSTANCES=1
layout(local_size_x = 64) in;

void main()
{
    uint i = gl_GlobalInvocationID.y * 65536u + gl_GlobalInvocationID.x;
    if (i >= glbk_csm_frame.end) return;
    uvec4 point = glbk_csm_asked[2u * i], light = glbk_csm_asked[2u * i + 1u];
    uint seed = glbk_csm_frame.roulette_seed;
    cohsm_query q = cohsm_query(CSM_ASK, CSM_FILTER, glbk_csm_frame.bias, seed, light.w);
    glbk_csm_answers[i] = csm_visible(point.w, q, uintBitsToFloat(point.xyz), uintBitsToFloat(light.xyz));
}
