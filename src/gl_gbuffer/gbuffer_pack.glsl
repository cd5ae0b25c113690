// gbuffer_pack - unit vectors in 32 bits, octahedral, off by less than 5e-5.
vec3 glbk_unit(vec3 v)              // 0 where the length is 0 or none
{
    float d = dot(v, v);
    return d > 0.0 ? v * inversesqrt(d) : vec3(0.0);
}

vec3 glbk_unit_of_square(vec2 p)    // octahedral, -1..1
{
    float z = 1.0 - abs(p.x) - abs(p.y), t = max(-z, 0.0);
    return glbk_unit(vec3(p.x + (p.x >= 0.0 ? -t : t), p.y + (p.y >= 0.0 ? -t : t), z));
}

uint glbk_pack_unit(vec3 n)         // zero: 0xffffffff
{
    float sum = abs(n.x) + abs(n.y) + abs(n.z);
    if (!(sum > 0.0)) return 0xffffffffu;
    n /= sum;
    vec2 p = n.z >= 0.0 ? n.xy : (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    uvec2 q = uvec2(floor(clamp(p * 0.5 + 0.5, 0.0, 1.0) * 65534.0 + 0.5));
    return q.x | (q.y << 16);
}

vec3 glbk_unpack_unit(uint bits)    // 0xffffffff: zero
{
    if (bits == 0xffffffffu) return vec3(0.0);
    return glbk_unit_of_square(vec2(float(bits & 0xffffu), float(bits >> 16)) * (2.0 / 65534.0) - 1.0);
}
