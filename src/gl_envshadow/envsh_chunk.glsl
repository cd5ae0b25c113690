// envsh_chunk - brings the table of lights into shared memory, 64 lights at a time, for compute shaders with
// 64 invocations in a group. The file comes before envsh_access, whose ENVSH_TEXEL it replaces.
// uses: table envsh_bindings

// The eight texels of a light are turned by its number. So no two of them meet in a bank of the memory,
// whether all invocations read one light or each reads its own.
#define ENVSH_TEXEL(i) envsh_chunk[((i) & 504u) | (((i) ^ ((i) >> 3)) & 7u)]
shared uvec4 envsh_chunk[512];

// Loads up to 64 lights, from number `from` on and below number `to`. A barrier has to follow.
void envsh_load_chunk(uint from, uint to)
{
    for (uint i = 8u * from + gl_LocalInvocationIndex; i < 8u * min(from + 64u, to); i += 64u)
        ENVSH_TEXEL(i) = texelFetch(glbk_envsh_views, glbk_table_at(i), 0);
}
