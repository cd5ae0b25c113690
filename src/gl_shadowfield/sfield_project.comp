// Does the work of sfield_project.frag as a compute shader: a work group is an eye and a channel. Each
// invocation projects its share of the texels on all harmonics, in registers; then the shares are added.
// uses: table sfield_bindings
// sets: SFIELD_SOURCE=0 SFIELD_BANDS=4 | SFIELD_SOURCE=1 SFIELD_BANDS=8
#ifndef SFIELD_BANDS
#define SFIELD_BANDS 4
#endif
#define SFIELD_GROUPS ((SFIELD_BANDS * SFIELD_BANDS + 3) / 4)
layout(local_size_x = 64) in;
shared vec4 sfield_shares[64 * SFIELD_GROUPS];

// Returns the integrals of four functions of the basis over a texel.
vec4 sfield_basis_at(uint i) { return uintBitsToFloat(texelFetch(glbk_sfield_basis, glbk_table_at(i), 0)); }

void main()
{
    uint eye = gl_WorkGroupID.x, channel = gl_WorkGroupID.y;
    uint side = glbk_sfield_views.side, cells = 6u * side * side;
    uint me = gl_LocalInvocationID.x;
    vec4 sum[SFIELD_GROUPS];
    for (int g = 0; g < SFIELD_GROUPS; g++) sum[g] = vec4(0.0);
    for (uint cell = me; cell < cells; cell += 64u) {
        uint x = cell % (6u * side), y = eye * side + cell / (6u * side);
#if SFIELD_SOURCE
        float a = uintBitsToFloat(texelFetch(glbk_sfield_cube, ivec2(x, y), 0)[channel]);
#else
        float a = uintBitsToFloat(texelFetch(glbk_sfield_cube, ivec2(x / 4u, y), 0)[x & 3u]);
#endif
        if (a != 0.0)
            for (int g = 0; g < SFIELD_GROUPS; g++) sum[g] += a * sfield_basis_at(uint(g) * cells + cell);
    }
    for (int g = 0; g < SFIELD_GROUPS; g++) sfield_shares[me * uint(SFIELD_GROUPS) + uint(g)] = sum[g];
    memoryBarrierShared();
    barrier();
    if (me >= uint(SFIELD_GROUPS)) return;
    vec4 all = vec4(0.0);
    for (uint i = 0u; i < 64u; i++) all += sfield_shares[i * uint(SFIELD_GROUPS) + me];
    imageStore(glbk_sfield_coefs_image, ivec2(channel * uint(SFIELD_GROUPS) + me, eye), floatBitsToUint(all));
}
