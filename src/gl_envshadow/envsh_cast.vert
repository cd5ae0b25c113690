// Puts a caster into the tile of a light. Its position stands where glbk_envsh_maps_desc says.
// uses: envsh_cast
// sets: ENVSH_RGBA=0 | ENVSH_RGBA=1
#ifndef GBUFFER_POSITION
#define GBUFFER_POSITION 0
#endif
layout(location = GBUFFER_POSITION) in vec3 position;
out float envsh_depth;

void main()
{
    ENVSH_CAST((glbk_envsh_object.transform * vec4(position, 1.0)).xyz)
}
