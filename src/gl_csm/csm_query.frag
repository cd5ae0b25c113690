// Answers a table of questions. Each has two texels: the point and the instance that it lies on; the light
// and a number for roulette.
// uses: csm_visible
// with: screen.vert
// sets: CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=1 CSM_INSTANCES=1
// sets: CSM_ASK=1 CSM_FILTER=2 | CSM_ASK=2 CSM_FILTER=1
// sets: CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=2 CSM_INSTANCES=1
// sets: CSM_ASK=0 CSM_FILTER=1 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=1 CSM_INSTANCES=1
// sets: CSM_ASK=0 CSM_FILTER=1 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=2 CSM_INSTANCES=1
layout(location = 0) out uvec4 result;

void main()
{
    uint i = uint(gl_FragCoord.y) * 1024u + uint(gl_FragCoord.x);
    result = uvec4(0u);
    if (i >= glbk_csm_frame.end) return;    // the last row is drawn whole
    uvec4 point = texelFetch(glbk_csm_questions, glbk_table_at(2u * i), 0);
    uvec4 light = texelFetch(glbk_csm_questions, glbk_table_at(2u * i + 1u), 0);
    uint seed = glbk_csm_frame.roulette_seed;
    cohsm_query q = cohsm_query(CSM_ASK, CSM_FILTER, glbk_csm_frame.bias, seed, light.w);
    float visible = csm_visible(point.w, q, uintBitsToFloat(point.xyz), uintBitsToFloat(light.xyz));
    result = uvec4(floatBitsToUint(visible), 0u, 0u, 0u);
}
