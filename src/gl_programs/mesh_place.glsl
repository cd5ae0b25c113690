// mesh_place - where the vertices of your meshes lie, for passes that draw nothing but depth, and texture
// coordinates, if a function of yours decides by them which pixels are there (glbk_attributes.fragment).
#ifdef GLBK_OWN_VERTEX
void glbk_vertex(out vec3 position, out vec3 normal, out vec2 uv, out vec4 tangent);
#else
#ifndef GBUFFER_POSITION
#define GBUFFER_POSITION 0
#define GBUFFER_UV 2
#endif
layout(location = GBUFFER_POSITION) in vec3 glbk_in_position;
#if defined(GLBK_OWN_FRAGMENT) && GBUFFER_UV >= 0
layout(location = GBUFFER_UV) in vec2 glbk_in_uv;
#else
const vec2 glbk_in_uv = vec2(0.0);
#endif
#endif
#ifdef GLBK_OWN_FRAGMENT
out vec2 glbk_uv;
#endif

// Returns the position of a vertex, in the space of its object.
vec3 glbk_vertex_place()
{
    vec3 position;
    vec2 uv;
#ifdef GLBK_OWN_VERTEX
    vec3 normal;
    vec4 tangent;
    glbk_vertex(position, normal, uv, tangent);
#else
    position = glbk_in_position;
    uv = glbk_in_uv;
#endif
#ifdef GLBK_OWN_FRAGMENT
    glbk_uv = uv;
#endif
    return position;
}
