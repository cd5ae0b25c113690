// Adds samples of one light to the running sum.
// uses: csm_shade
// with: screen.vert
// sets: CSM_SHAPE=1 CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=2 CSM_INSTANCES=1
// sets: CSM_SHAPE=6 CSM_ASK=2 CSM_FILTER=2 COHSM_LOBES=8 CSM_PATTERNS=1
layout(location = 0) out glbk_color result;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 sum = glbk_csm_frame.adds != 0u ? glbk_unpack(texelFetch(glbk_csm_sum, at, 0)) : vec4(0.0);
    glbk_point p;
    if (glbk_read_point(at, p)) sum += csm_shade(p, uint(at.y) * glbk_csm_frame.width + uint(at.x));
    result = glbk_pack(sum);
}
