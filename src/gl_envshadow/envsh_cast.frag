// Writes the depth of a caster.
// uses: envsh_cast mesh_fragment
// with: envsh_cast.vert
// sets: ENVSH_RGBA=0 GLBK_PLACE | ENVSH_RGBA=1 GLBK_PLACE
in float envsh_depth;
#if ENVSH_RGBA
layout(location = 0) out uvec4 envsh_bits;
#endif

void main()
{
    if (glbk_is_hole()) discard;
    ENVSH_STORE(envsh_depth)
}
