// ism_corners - reads the triangles of the mesh.
// uses: table ism_bindings
struct ism_corners { vec3 a, b, c; };

vec3 ism_vertex(uint i) { return texelFetch(glbk_ism_positions, glbk_table_at(i), 0).xyz; }

ism_corners ism_read_corners(uint t)
{
    uvec3 i = texelFetch(glbk_ism_triangles, glbk_table_at(t), 0).xyz;
    return ism_corners(ism_vertex(i.x), ism_vertex(i.y), ism_vertex(i.z));
}

// Returns the cross product of two edges: the normal, as long as twice the area.
vec3 ism_normal2(ism_corners p) { return cross(p.b - p.a, p.c - p.a); }
