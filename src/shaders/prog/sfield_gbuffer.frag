// One object into the G-buffer; at most 4 bands of own visibility, interpolated between the vertices.
// uses: sfield_bindings
// with: sfield_gbuffer.vert
in vec3 sfield_place_at, sfield_facing;
in vec4 sfield_self0, sfield_self1, sfield_self2, sfield_self3;
layout(location = 0) out uvec4 sfield_out_place;
layout(location = 1) out uvec4 sfield_out_normal;
layout(location = 2) out uvec4 sfield_out_self0;
layout(location = 3) out uvec4 sfield_out_self1;

uvec2 sfield_halves(vec4 v)
{
    ivec4 q = ivec4(floor(clamp(v * (1.0 / 1.5), -1.0, 1.0) * 32767.0 + 0.5));
    uvec4 u = uvec4(q) & 0xffffu;
    return u.xz | (u.yw << 16);
}

void main()
{
    uvec4 kinds = glbk_sfield_object.kinds;     // entity, 1 where attributes 2 to 5 are there
    float exponent = glbk_sfield_object.gloss.x;
    vec3 n = sfield_facing * inversesqrt(max(dot(sfield_facing, sfield_facing), 1e-30));
    sfield_out_place = uvec4(floatBitsToUint(sfield_place_at), kinds.x);
    sfield_out_normal = uvec4(floatBitsToUint(n), floatBitsToUint(exponent) | (kinds.y << 31));
    sfield_out_self0 = uvec4(sfield_halves(sfield_self0), sfield_halves(sfield_self1));
    sfield_out_self1 = uvec4(sfield_halves(sfield_self2), sfield_halves(sfield_self3));
}
