// Attributes 0 position, 1 normal, 2 texture coordinates, 3 tangent (w: handedness).
// uses: csm_bindings
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in vec4 tangent;
out vec3 csm_place, csm_facing;
out vec2 csm_uv;
out vec4 csm_along;

void main()
{
    mat3 m = mat3(glbk_csm_object.world);
    csm_place = (glbk_csm_object.world * vec4(position, 1.0)).xyz;
    csm_facing = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * normal;
    csm_along = vec4(m * tangent.xyz, tangent.w);
    csm_uv = uv;
    gl_Position = glbk_csm_object.clip * vec4(csm_place, 1.0);
}
