// Irradiance times albedo / pi, as colours.
// uses: envsh_bindings
// with: screen.vert
layout(location = 0) out vec4 result;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy) - ivec2(glbk_envsh_object.lights.xy);
    vec3 albedo = uintBitsToFloat(texelFetch(glbk_envsh_color, at, 0).xyz);
    vec3 sum = glbk_envsh_object.lights.w != 0u ? glbk_unpack(texelFetch(glbk_envsh_sum, at, 0)).xyz : vec3(0.0);
    result = vec4(sum * albedo * 0.318309886, 1.0);
}
