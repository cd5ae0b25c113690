// Puts a caster into the tile of a light.
// uses: envsh_cast mesh_vertex
// sets: ENVSH_RGBA=0 GLBK_PLACE | ENVSH_RGBA=1 GLBK_PLACE
out float envsh_depth;

void main()
{
    ENVSH_CAST((glbk_envsh_object.transform * vec4(glbk_vertex_place(), 1.0)).xyz)
}
