// Answers a table of questions, two texels each: point, instance that it lies on; light, number for roulette.
// uses: csm_visible
// with: screen.vert
// sets: CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 CSM_INSTANCES=1 | CSM_ASK=1 CSM_FILTER=2 | CSM_ASK=2 CSM_FILTER=1
layout(location = 0) out uvec4 result;

void main()
{
    uint i = uint(gl_FragCoord.y) * 1024u + uint(gl_FragCoord.x);
    result = uvec4(0u);
    if (i >= glbk_csm_frame.range.x) return;    // the last row is drawn whole
    uvec4 point = texelFetch(glbk_csm_questions, glbk_table_at(2u * i), 0);
    uvec4 light = texelFetch(glbk_csm_questions, glbk_table_at(2u * i + 1u), 0);
    uvec4 range = glbk_csm_frame.range;
    cohsm_query q = cohsm_query(CSM_ASK, CSM_FILTER, glbk_csm_frame.query.x, range.w, light.w);
    result = uvec4(floatBitsToUint(csm_visible(point.w, q, uintBitsToFloat(point.xyz), uintBitsToFloat(light.xyz))),
                   0u, 0u, 0u);
}
