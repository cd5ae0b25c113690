// Does what csm_shade.frag does, as a compute shader: the sum is an image, changed in place.
// uses: csm_shade
// sets: CSM_SHAPE=1 CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=2 CSM_INSTANCES=1
// sets: CSM_SHAPE=6 CSM_ASK=2 CSM_FILTER=2 COHSM_LOBES=8 CSM_PATTERNS=1
layout(local_size_x = 8, local_size_y = 8) in;

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    uint pixel = uint(at.y) * glbk_csm_frame.width + uint(at.x);
    glbk_point p;
    if (uint(at.x) >= glbk_csm_frame.width || uint(at.y) >= glbk_csm_frame.height) return;
    vec4 sum = glbk_csm_frame.adds != 0u ? imageLoad(glbk_csm_total, at) : vec4(0.0);
    if (glbk_read_point(at, p)) sum += csm_shade(p, pixel);
    imageStore(glbk_csm_total, at, sum);
}
