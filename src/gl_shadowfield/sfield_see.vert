// Draws a mesh as seen from the eyes of a column of tiles, one tile an instance. The viewport is the column
// and clips along x; the near and far planes do so along y, so that no triangle leaves its tile. The
// radiance stands where glbk_sfield_builder_desc says.
// uses: sfield_bindings mesh_vertex
// sets: SFIELD_SOURCE=0 GLBK_PLACE | SFIELD_SOURCE=1 GLBK_PLACE
#ifndef SFIELD_RADIANCE
#define SFIELD_RADIANCE 1
#endif
#if SFIELD_SOURCE
layout(location = SFIELD_RADIANCE) in vec3 radiance;
flat out vec3 sfield_radiance;
out float sfield_depth;
#endif

// Returns p along s, t and the axis of a face, which are those of sfield_cube_texel.
vec3 sfield_to_face(uint face, vec3 p)
{
    if (face == 0u) return vec3(-p.z, -p.y, p.x);
    if (face == 1u) return vec3(p.z, -p.y, -p.x);
    if (face == 2u) return vec3(p.x, p.z, p.y);
    if (face == 3u) return vec3(p.x, -p.z, -p.y);
    return face == 4u ? vec3(p.x, -p.y, p.z) : vec3(-p.x, -p.y, -p.z);
}

void main()
{
    uint tile = glbk_sfield_views.first_tile + uint(gl_InstanceID);
    vec4 eye = glbk_sfield_views.eyes[tile];
    uvec4 place = glbk_sfield_views.places[tile];
    vec4 sphere = glbk_sfield_views.sphere;
    vec3 q = sfield_to_face(place.x, (glbk_vertex_place() - sphere.xyz) / sphere.w - eye.xyz);
    float rows = float(glbk_sfield_views.rows);
    gl_Position = vec4(q.x, (q.y + (float(2u * place.w) + 1.0) * q.z) / rows - q.z, q.y, q.z);
#if SFIELD_SOURCE
    sfield_radiance = radiance;
    sfield_depth = q.z * eye.w;
#endif
}
