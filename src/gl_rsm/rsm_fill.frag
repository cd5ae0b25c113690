// Draws one object into a face of a map.
// uses: rsm_bindings rsm_bound mesh_fragment
// with: rsm_fill.vert
in vec3 rsm_place, rsm_facing;
in vec2 rsm_uv;
layout(location = 0) out uvec4 rsm_out_place;
layout(location = 1) out uvec4 rsm_out_normal;
layout(location = 2) out uvec4 rsm_out_flux;

void main()
{
    vec4 color = vec4(glbk_rsm_drawn.albedo.xyz, 1.0);
    vec4 eye = glbk_rsm_drawn.eye;
    vec3 view = eye.w > 0.0 ? eye.xyz - rsm_place : eye.xyz;
    vec3 flat_normal = rsm_normalize(cross(dFdx(rsm_place), dFdy(rsm_place)));
    // Very far out, all places of a triangle are one.
    if (dot(flat_normal, flat_normal) == 0.0) flat_normal = rsm_normalize(rsm_facing);
    if (dot(flat_normal, view) < 0.0) flat_normal = -flat_normal;
    vec3 n = dot(rsm_facing, rsm_facing) > 0.0 ? rsm_normalize(rsm_facing) : flat_normal;
    if (dot(n, flat_normal) < 0.0) n = -n;
    if (glbk_rsm_drawn.has_map != 0u) {
        color.xyz *= texture(glbk_rsm_albedo_map, rsm_uv).xyz;
        color.w = textureLod(glbk_rsm_albedo_map, rsm_uv, 0.0).w;
    }
    bool there = glbk_fragment(rsm_uv, color);
    if (!there || color.w < glbk_rsm_drawn.alpha_cutoff) discard;
    rsm_light l = rsm_bound();
    int face = int(glbk_rsm_drawn.face);
    vec3 r, u, a, flux = rsm_incident(l, face, ivec2(gl_FragCoord.xy)) * l.value * color.xyz;
    // By bits, since compilers may turn comparisons round as if there were no NaNs: more than 1e18, or no number.
    if (any(greaterThan(floatBitsToUint(flux) & 0x7fffffffu, uvec3(0x5d5e0b6bu)))) flux = vec3(0.0);
    rsm_face_axes(l, face, r, u, a);
    float depth = dot(rsm_place - l.position, a);
    gl_FragDepth = clamp((depth - glbk_rsm_drawn.near_depth) * glbk_rsm_drawn.depth_scale, 0.0, 1.0);
    rsm_out_place = floatBitsToUint(vec4(rsm_place, depth));
    rsm_out_normal = uvec4(floatBitsToUint(n), glbk_rsm_drawn.material);
    rsm_out_flux = floatBitsToUint(vec4(flux, rsm_area(l, face, rsm_place, n)));
}
