// Places a vertex in a face of a map.
// uses: rsm_bindings mesh_vertex
out vec3 rsm_place, rsm_facing;
out vec2 rsm_uv;

void main()
{
    vec3 position, normal;
    vec2 uv;
    vec4 tangent;
    glbk_vertex(position, normal, uv, tangent);
    mat3 m = mat3(glbk_rsm_drawn.transform);
    rsm_place = (glbk_rsm_drawn.transform * vec4(position, 1.0)).xyz;
    rsm_facing = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * normal;
    rsm_uv = uv;
    gl_Position = glbk_rsm_drawn.clip * vec4(rsm_place, 1.0);
}
