// mesh_vertex - the vertices of your meshes: their attributes, or what a function of yours makes of them
// (glbk_attributes.vertex). Passes that draw nothing but depth define GLBK_PLACE: they read the position
// alone, and texture coordinates where a function of yours decides by them which pixels are there.
#ifdef GLBK_OWN_VERTEX
void glbk_vertex(out vec3 position, out vec3 normal, out vec2 uv, out vec4 tangent);
#else
#ifndef GBUFFER_POSITION
#define GBUFFER_POSITION 0
#define GBUFFER_NORMAL 1
#define GBUFFER_UV 2
#define GBUFFER_TANGENT 3
#endif
layout(location = GBUFFER_POSITION) in vec3 glbk_in_position;
#if GBUFFER_NORMAL >= 0 && !defined(GLBK_PLACE)
layout(location = GBUFFER_NORMAL) in vec3 glbk_in_normal;
#else
const vec3 glbk_in_normal = vec3(0.0);
#endif
#if GBUFFER_UV >= 0 && (!defined(GLBK_PLACE) || defined(GLBK_OWN_FRAGMENT))
layout(location = GBUFFER_UV) in vec2 glbk_in_uv;
#else
const vec2 glbk_in_uv = vec2(0.0);
#endif
#if GBUFFER_TANGENT >= 0 && !defined(GLBK_PLACE)
layout(location = GBUFFER_TANGENT) in vec4 glbk_in_tangent;
#else
const vec4 glbk_in_tangent = vec4(0.0);
#endif

void glbk_vertex(out vec3 position, out vec3 normal, out vec2 uv, out vec4 tangent)
{
    position = glbk_in_position;
    normal = glbk_in_normal;
    uv = glbk_in_uv;
    tangent = glbk_in_tangent;
}
#endif
#ifdef GLBK_PLACE
#ifdef GLBK_OWN_FRAGMENT
out vec2 glbk_uv;
#endif

// Returns the position of a vertex, in the space of its object.
vec3 glbk_vertex_place()
{
    vec3 position, normal;
    vec2 uv;
    vec4 tangent;
    glbk_vertex(position, normal, uv, tangent);
#ifdef GLBK_OWN_FRAGMENT
    glbk_uv = uv;
#endif
    return position;
}
#endif
