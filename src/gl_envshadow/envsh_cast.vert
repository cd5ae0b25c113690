// Puts a caster into the tile of a light: attribute 0 is its position.
// uses: envsh_cast
// sets: ENVSH_RGBA=0 | ENVSH_RGBA=1
layout(location = 0) in vec3 position;
out float envsh_depth;

void main()
{
    ENVSH_CAST((glbk_envsh_object.transform * vec4(position, 1.0)).xyz)
}
