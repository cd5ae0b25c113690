// One object into the G-buffer: place (w: 1), shading normal, the surface's own normal, albedo.
// uses: envsh_bindings
// with: envsh_gbuffer.vert
in vec3 envsh_at, envsh_facing;
in vec2 envsh_uv;
layout(location = 0) out uvec4 envsh_out_place;
layout(location = 1) out uvec4 envsh_out_normal;
layout(location = 2) out uvec4 envsh_out_flat;
layout(location = 3) out uvec4 envsh_out_color;

vec3 envsh_unit(vec3 v)
{
    float d = dot(v, v);
    return d > 0.0 ? v * inversesqrt(d) : vec3(0.0);
}

void main()
{
    vec4 color = glbk_envsh_object.color;
    vec3 flat_n = envsh_unit(cross(dFdx(envsh_at), dFdy(envsh_at)));
    if (dot(flat_n, flat_n) == 0.0) flat_n = envsh_unit(envsh_facing);      // so far out, all one place
    if (dot(flat_n, glbk_envsh_object.eye.xyz - envsh_at) < 0.0) flat_n = -flat_n;
    vec3 n = dot(envsh_facing, envsh_facing) > 0.0 ? envsh_unit(envsh_facing) : flat_n;
    if (dot(n, flat_n) < 0.0) n = -n;
    if (glbk_envsh_object.lights.z != 0u) color *= texture(glbk_envsh_color_map, envsh_uv);
    if (color.a < glbk_envsh_object.eye.w) discard;
    envsh_out_place = floatBitsToUint(vec4(envsh_at, 1.0));
    envsh_out_normal = floatBitsToUint(vec4(n, 0.0));
    envsh_out_flat = floatBitsToUint(vec4(flat_n, 0.0));
    envsh_out_color = floatBitsToUint(vec4(color.rgb, 0.0));
}
