// Radiance: albedo / pi times direct and bounced light.
// uses: rsm_access
// with: screen.vert
layout(location = 0) out vec4 result;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy) - ivec2(glbk_rsm_frame.range.xy);
    vec3 light = vec3(0.0), albedo = uintBitsToFloat(RSM_SEEN(at, 2).xyz);
    if (glbk_rsm_frame.mode.x != 0u) light += glbk_unpack(texelFetch(glbk_rsm_sum, at, 0)).xyz;
    if (glbk_rsm_frame.mode.y != 0u) light += glbk_unpack(texelFetch(glbk_rsm_states, at, 0)).xyz;
    result = vec4(albedo * light / RSM_PI, 1.0);
}
