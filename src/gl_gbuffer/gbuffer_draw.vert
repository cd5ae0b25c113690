// Places the vertices of one object. A tangent has its handedness in w.
// uses: gbuffer_drawn mesh_vertex
invariant gl_Position;              // sfield_self.vert draws the same objects and must find the same depths
out vec3 glbk_place, glbk_facing;
out vec2 glbk_uv;
out vec4 glbk_along;

void main()
{
    vec3 position, normal;
    vec2 uv;
    vec4 tangent;
    glbk_vertex(position, normal, uv, tangent);
    mat3 m = mat3(glbk_gbuffer_drawn.transform);
    glbk_place = (glbk_gbuffer_drawn.transform * vec4(position, 1.0)).xyz;
    glbk_facing = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * normal;
    glbk_along = vec4(m * tangent.xyz, tangent.w);
    glbk_uv = uv;
    gl_Position = glbk_gbuffer_drawn.clip * vec4(glbk_place, 1.0);
}
