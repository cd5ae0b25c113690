// One object into the G-buffer, with diffuse, specular and normal maps.
// uses: csm_gbuffer
// with: csm_gbuffer.vert
in vec3 csm_place, csm_facing;
in vec2 csm_uv;
in vec4 csm_along;
layout(location = 0) out uvec4 csm_out_place;
layout(location = 1) out uvec4 csm_out_normal;
layout(location = 2) out uvec4 csm_out_color;
layout(location = 3) out uvec4 csm_out_gloss;

void main()
{
    uvec4 kinds = glbk_csm_object.kinds;        // BRDF, instance or COHSM_NO_SELF, 1 + plane, maps as bits
    vec3 view = glbk_csm_object.eye.xyz - csm_place;
    vec3 flat_normal = cohsm_normalize(cross(dFdx(csm_place), dFdy(csm_place)));
    if (dot(flat_normal, flat_normal) == 0.0) flat_normal = cohsm_normalize(csm_facing);    // so far out, all one place
    if (dot(flat_normal, view) < 0.0) flat_normal = -flat_normal;
    vec3 n = dot(csm_facing, csm_facing) > 0.0 ? cohsm_normalize(csm_facing) : flat_normal;
    if (dot(n, flat_normal) < 0.0) n = -n;
    vec3 t = csm_along.xyz - n * dot(csm_along.xyz, n);
    bool has_tangent = dot(t, t) > 0.0;
    if (has_tangent) t = cohsm_normalize(t);
    if ((kinds.w & 4u) != 0u) {                 // fetched where all of a quad do, for the level
        vec3 bump = texture(glbk_csm_normal_map, csm_uv).xyz * 2.0 - 1.0;
        bump.y *= csm_along.w < 0.0 ? -1.0 : 1.0;
        if (has_tangent) n = cohsm_normalize(t * bump.x + cross(n, t) * bump.y + n * bump.z);
    }
    vec3 diffuse = glbk_csm_object.diffuse.xyz;
    vec4 gloss = glbk_csm_object.gloss;
    if ((kinds.w & 1u) != 0u) diffuse *= texture(glbk_csm_color_map, csm_uv).xyz;
    if ((kinds.w & 2u) != 0u) {
        vec4 map = texture(glbk_csm_gloss_map, csm_uv);
        if (kinds.x == COHSM_BRDF_PHONG) gloss.xyz *= map.xyz;
        if (kinds.x == COHSM_BRDF_METAL_ROUGH) gloss.xy *= map.zy;      // glTF: roughness in g, metallic in b
    }
    csm_out_place = uvec4(floatBitsToUint(csm_place), kinds.y);
    csm_out_normal = uvec4(floatBitsToUint(n), kinds.x | (kinds.z << 8));
    csm_out_color = uvec4(floatBitsToUint(diffuse), csm_pack_unit(flat_normal));
    csm_out_gloss = kinds.x == COHSM_BRDF_LAFORTUNE
                        ? uvec4(glbk_csm_object.lobes.xy, has_tangent ? csm_pack_unit(t) : 0xffffffffu, 0u)
                        : floatBitsToUint(gloss);
}
