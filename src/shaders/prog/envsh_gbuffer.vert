// Attributes 0 position, 1 normal, 2 texture coordinates.
// uses: envsh_bindings
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
out vec3 envsh_at, envsh_facing;
out vec2 envsh_uv;

void main()
{
    mat3 m = mat3(glbk_envsh_object.world);
    envsh_at = (glbk_envsh_object.world * vec4(position, 1.0)).xyz;
    envsh_facing = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * normal;
    envsh_uv = uv;
    gl_Position = glbk_envsh_object.clip * vec4(envsh_at, 1.0);
}
