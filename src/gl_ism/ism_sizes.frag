// Draws of each triangle its area and its mean solid angle as seen from receivers of the picture (paper 5.1,
// 5.2), which are drawn for each triangle, or of which one is the same for all.
// uses: cohsm_math ism_corners ism_fold ism_hash
// with: screen.vert
layout(location = 0) out uvec2 result;

// Returns the upper half of the product of 64 bits.
uint ism_multiply_high(uint a, uint b)
{
    uint a0 = a & 0xffffu, a1 = a >> 16, b0 = b & 0xffffu, b1 = b >> 16;
    uint middle = a1 * b0 + (a0 * b0 >> 16), rest = a0 * b1 + (middle & 0xffffu);
    return a1 * b1 + (middle >> 16) + (rest >> 16);
}

// Returns the solid angle of a triangle seen from the origin (Van Oosterom and Strackee 1983).
float ism_solid_angle(vec3 a, vec3 b, vec3 c)
{
    float la = length(a), lb = length(b), lc = length(c);
    float top = abs(dot(a, cross(b, c)));
    float below = la * lb * lc + dot(a, b) * lc + dot(a, c) * lb + dot(b, c) * la;
    float omega = 0.0;
    if (top > 0.0 && cohsm_finite(top) && cohsm_finite(below)) omega = max(2.0 * cohsm_atan2(top, below), 0.0);
    return omega;
}

// Returns the solid angle seen from a receiver. One small for its distance is taken for area cos / d^2,
// whose relative error is at most area / d^2.
float ism_solid_angle_from(vec3 eye, ism_corners p, vec3 normal2, float area2)
{
    vec3 a = p.a - eye;
    float d2 = dot(a, a), omega = 0.5 * abs(dot(normal2, a)) / (d2 * sqrt(d2));
    if (!(0.01 * d2 > area2)) omega = ism_solid_angle(a, p.b - eye, p.c - eye);
    return omega;
}

void main()
{
    uint count = ISM_S.triangle_count, views = ISM_S.views;
    uint t = ism_unfold(count).x;
    result = uvec2(0u);
    if (t >= count) return;
    ism_corners p = ism_read_corners(t);
    vec3 normal2 = ism_normal2(p);
    float area2 = length(normal2), solid = 0.0;
    if (!(area2 > 0.0) || !cohsm_finite(area2)) return;
    uint pixels = ISM_S.view_width * ISM_S.view_height, valid = 0u;
    if (views > 0u) {
        ivec2 end = textureSize(glbk_ism_runs4, 0) - 1;
        valid = uint(ISM_FLOATS(glbk_ism_runs4, end).x);
    }
    uint key = ism_hash_combine(ISM_S.seed, 0x7000u + cohsm_if(views == 1u, 0u, t));
    for (uint k = 0u; k < views && valid > 0u; k++) {
        uint i = ism_multiply_high(ism_hash_combine(key, k), valid);
        vec3 eye = ISM_FLOATS(glbk_ism_receivers, ism_fold(i, pixels, 0u)).xyz;
        solid += ism_solid_angle_from(eye, p, normal2, area2);
    }
    if (views > 0u) solid /= float(views);
    if (!cohsm_finite(solid)) solid = 0.0;
    result = floatBitsToUint(vec2(0.5 * area2, solid));
}
