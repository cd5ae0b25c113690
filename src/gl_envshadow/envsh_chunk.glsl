// envsh_chunk - the lights' table through shared memory, 64 lights at a time, for groups of 64; before envsh_access.
// uses: table envsh_bindings

// A light's eight texels are turned by its number: neither one light for all threads nor one for each meet in a bank.
#define ENVSH_TEXEL(i) envsh_chunk[((i) & 504u) | (((i) ^ ((i) >> 3)) & 7u)]
shared uvec4 envsh_chunk[512];

void envsh_load_chunk(uint from, uint to)
{
    for (uint i = 8u * from + gl_LocalInvocationIndex; i < 8u * min(from + 64u, to); i += 64u)
        ENVSH_TEXEL(i) = texelFetch(glbk_envsh_views, glbk_table_at(i), 0);
}
