// Draws irradiance times albedo / pi.
// uses: envsh_bindings gbuffer picture
// with: screen.vert
layout(location = 0) out vec4 result;

void main()
{
    ivec2 at = glbk_picture_at();
    glbk_point p;
    bool seen = glbk_read_point(at, p);
    glbk_picture_show(seen, p.position);
    vec3 albedo = seen ? p.diffuse * (1.0 - p.metallic) : vec3(0.0), sum = vec3(0.0);
    if (glbk_envsh_object.lit != 0u) sum = glbk_unpack(texelFetch(glbk_envsh_sum, at, 0)).xyz;
    result = vec4(sum * albedo * 0.318309886, 1.0);
}
