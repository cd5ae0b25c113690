// csm_gbuffer - the G-buffer of glbk_csm: four RGBA32UI textures, floats as their bits (docs/gpu-layouts.md).
// uses: csm_point
uint csm_pack_unit(vec3 n)          // a unit vector in 32 bits, octahedral; zero: 0xffffffff
{
    float sum = abs(n.x) + abs(n.y) + abs(n.z);
    if (!(sum > 0.0)) return 0xffffffffu;
    n /= sum;
    vec2 p = n.z >= 0.0 ? n.xy : (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    uvec2 q = uvec2(floor(clamp(p * 0.5 + 0.5, 0.0, 1.0) * 65534.0 + 0.5));
    return q.x | (q.y << 16);
}

vec3 csm_unpack_unit(uint bits)     // 0xffffffff: none, zero
{
    if (bits == 0xffffffffu) return vec3(0.0);
    vec2 p = vec2(float(bits & 0xffffu), float(bits >> 16)) * (2.0 / 65534.0) - 1.0;
    float z = 1.0 - abs(p.x) - abs(p.y), t = max(-z, 0.0);
    return cohsm_normalize(vec3(p.x + (p.x >= 0.0 ? -t : t), p.y + (p.y >= 0.0 ? -t : t), z));
}

// false: nothing is seen there.
bool csm_read_point(ivec2 at, out csm_point p)
{
    uvec4 place = texelFetch(glbk_csm_place, at, 0), normal = texelFetch(glbk_csm_normal, at, 0);
    uvec4 color = texelFetch(glbk_csm_color, at, 0), gloss = texelFetch(glbk_csm_gloss, at, 0);
    p.position = uintBitsToFloat(place.xyz);
    p.self = place.w;
    p.normal = uintBitsToFloat(normal.xyz);
    p.plane = (normal.w >> 8) & 0xffu;
    p.geometric = csm_unpack_unit(color.w);
    p.tangent = vec3(0.0);
    uint type = normal.w & 0xffu;
    vec4 values = uintBitsToFloat(gloss);
    p.material = cohsm_material(type, uintBitsToFloat(color.xyz), vec3(0.0), 0.0, 0.0, 0.0, 0u, 0u);
    if (type == COHSM_BRDF_PHONG) {
        p.material.specular = values.xyz;
        p.material.exponent = values.w;
    } else if (type == COHSM_BRDF_METAL_ROUGH) {
        p.material.metallic = values.x;
        p.material.roughness = values.y;
    } else if (type == COHSM_BRDF_LAFORTUNE) {
        p.material.lobe = gloss.x;
        p.material.lobe_count = gloss.y;
        p.tangent = csm_unpack_unit(gloss.z);
    }
    return type != 0u;
}
