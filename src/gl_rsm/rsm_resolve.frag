// Draws radiance: albedo / pi times direct and bounced light.
// uses: rsm_access gbuffer picture
// with: screen.vert
layout(location = 0) out vec4 result;

void main()
{
    ivec2 at = glbk_picture_at();
    vec3 light = vec3(0.0);
    glbk_point p;
    bool seen = glbk_read_point(at, p);
    glbk_picture_show(seen, p.position);
    if (glbk_rsm_frame.shows_direct != 0u) light += glbk_unpack(texelFetch(glbk_rsm_sum, at, 0)).xyz;
    if (glbk_rsm_frame.shows_bounced != 0u) light += glbk_unpack(texelFetch(glbk_rsm_states, at, 0)).xyz;
    result = vec4(p.diffuse * (1.0 - p.metallic) * light / RSM_PI, 1.0);
}
