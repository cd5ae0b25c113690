// Writes self-visibility of one object, of at most 4 bands, interpolated between the vertices.
// with: sfield_self.vert
// sets: GLBK_PLACE
in vec4 sfield_self0, sfield_self1, sfield_self2, sfield_self3;
layout(location = 0) out uvec4 sfield_out_self0;
layout(location = 1) out uvec4 sfield_out_self1;

// Packs four coefficients into 16 bits each, with 32767 for 1.5.
uvec2 sfield_halves(vec4 v)
{
    ivec4 q = ivec4(floor(clamp(v * (1.0 / 1.5), -1.0, 1.0) * 32767.0 + 0.5));
    uvec4 u = uvec4(q) & 0xffffu;
    return u.xz | (u.yw << 16);
}

void main()
{
    sfield_out_self0 = uvec4(sfield_halves(sfield_self0), sfield_halves(sfield_self1));
    sfield_out_self1 = uvec4(sfield_halves(sfield_self2), sfield_halves(sfield_self3));
    if ((sfield_out_self0.x & 0xffffu) == 0u) sfield_out_self0.x |= 1u;     // since 0 says: not recorded
}
