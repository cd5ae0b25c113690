// Places a vertex in a face of a map. Attributes stand where glbk_rsm_renderer_desc says; if a location is
// below 0, the mesh has no such attribute.
// uses: rsm_bindings
#ifndef GBUFFER_POSITION
#define GBUFFER_POSITION 0
#define GBUFFER_NORMAL 1
#define GBUFFER_UV 2
#endif
layout(location = GBUFFER_POSITION) in vec3 position;
#if GBUFFER_NORMAL >= 0
layout(location = GBUFFER_NORMAL) in vec3 normal;
#else
const vec3 normal = vec3(0.0);
#endif
#if GBUFFER_UV >= 0
layout(location = GBUFFER_UV) in vec2 uv;
#else
const vec2 uv = vec2(0.0);
#endif
out vec3 rsm_place, rsm_facing;
out vec2 rsm_uv;

void main()
{
    mat3 m = mat3(glbk_rsm_drawn.transform);
    rsm_place = (glbk_rsm_drawn.transform * vec4(position, 1.0)).xyz;
    rsm_facing = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * normal;
    rsm_uv = uv;
    gl_Position = glbk_rsm_drawn.clip * vec4(rsm_place, 1.0);
}
