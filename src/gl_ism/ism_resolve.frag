// Draws irradiance times albedo / pi.
// uses: ism_bindings gbuffer picture
// with: screen.vert
layout(location = 0) out vec4 result;

void main()
{
    ivec2 at = glbk_picture_at();
    glbk_point p;
    bool seen = glbk_read_point(at, p);
    glbk_picture_show(seen, p.position);
    vec3 albedo = seen ? p.diffuse * (1.0 - p.metallic) : vec3(0.0);
    result = vec4(glbk_unpack(texelFetch(glbk_ism_light, at, 0)).xyz * albedo * 0.318309886, 1.0);
}
