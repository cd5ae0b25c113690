// Places the vertices of one object. Attributes stand where glbk_gbuffer_desc says; if a location is below 0,
// the mesh has no such attribute. A tangent has its handedness in w.
// uses: gbuffer_drawn
#ifndef GBUFFER_POSITION
#define GBUFFER_POSITION 0
#define GBUFFER_NORMAL 1
#define GBUFFER_UV 2
#define GBUFFER_TANGENT 3
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
#if GBUFFER_TANGENT >= 0
layout(location = GBUFFER_TANGENT) in vec4 tangent;
#else
const vec4 tangent = vec4(0.0);
#endif
invariant gl_Position;              // sfield_self.vert draws the same objects and must find the same depths
out vec3 glbk_place, glbk_facing;
out vec2 glbk_uv;
out vec4 glbk_along;

void main()
{
    mat3 m = mat3(glbk_gbuffer_drawn.transform);
    glbk_place = (glbk_gbuffer_drawn.transform * vec4(position, 1.0)).xyz;
    glbk_facing = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * normal;
    glbk_along = vec4(m * tangent.xyz, tangent.w);
    glbk_uv = uv;
    gl_Position = glbk_gbuffer_drawn.clip * vec4(glbk_place, 1.0);
}
