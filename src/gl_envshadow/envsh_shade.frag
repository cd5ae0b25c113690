// Adds the light of some lights to the irradiance of each pixel.
// uses: envsh_light gbuffer
// with: screen.vert
// sets: ENVSH_FILTER=1 ENVSH_RGBA=0 | ENVSH_FILTER=2 ENVSH_RGBA=1
// sets: ENVSH_FILTER=3 ENVSH_RGBA=0 | ENVSH_FILTER=4 ENVSH_RGBA=1
layout(location = 0) out glbk_color result;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 sum = vec3(0.0);
    glbk_point p;
    if (glbk_envsh_query.adds != 0u) sum = glbk_unpack(texelFetch(glbk_envsh_sum, at, 0)).xyz;
    if (glbk_read_point(at, p)) {
        uint index = uint(at.y) * uint(textureSize(glbk_gbuffer_place, 0).x) + uint(at.x);
        sum += envsh_irradiance(envsh_bound_query(), glbk_envsh_query.first_light, glbk_envsh_query.end_light,
                                p.position, p.normal, p.geometric, index);
    }
    result = glbk_pack(vec4(sum, 0.0));
}
