// Draws the box of the receivers: FROM=0 of 64 receivers each, 1024 boxes of at most 65,536 that are spread over
// the picture; FROM=1 the box of 32 boxes of the picture before. Two pictures: the lower corner and the upper.
// uses: cohsm_math ism_choice gbuffer
// with: screen.vert
// sets: FROM=0 | FROM=1
#ifndef FROM
#define FROM 0
#endif
layout(location = 0) out uvec4 lower;
layout(location = 1) out uvec4 upper;

void main()
{
    ivec2 at = ISM_HERE;
    vec3 lo = vec3(1e30), hi = vec3(-1e30);
#if FROM == 0
    uint count = ISM_C.view_width * ISM_C.view_height, pace = count / 65536u + 1u;
    for (uint k = 0u; k < 64u; k++) {
        uint i = (uint(at.y) * 32u + uint(at.x) + 1024u * k) * pace;
        uint j = min(i, count - 1u);
        glbk_point p;
        bool seen = glbk_read_point(ivec2(j % ISM_C.view_width, j / ISM_C.view_width), p);
        if (seen && i < count && cohsm_finite3(p.position)) {
            lo = min(lo, p.position);
            hi = max(hi, p.position);
        }
    }
#else
    for (int k = 0; k < 32; k++) {
        lo = min(lo, ISM_FLOATS(glbk_ism_box, ivec3(k, at.x, 0)).xyz);
        hi = max(hi, ISM_FLOATS(glbk_ism_box, ivec3(k, at.x, 1)).xyz);
    }
#endif
    lower = uvec4(floatBitsToUint(lo), 0u);
    upper = uvec4(floatBitsToUint(hi), 0u);
}
