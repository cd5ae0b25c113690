// gbuffer_write - what a pixel of the G-buffer gets, from a block's material (glbk_gbuffer_drawn or _imported).
// uses: gbuffer_pack
layout(location = 0) out uvec4 glbk_out_place;
layout(location = 1) out uvec4 glbk_out_normal;
layout(location = 2) out uvec4 glbk_out_color;
layout(location = 3) out uvec4 glbk_out_gloss;

// numbers: kind, entity, plane, as in both blocks. map: red, green, blue of the gloss map, or 1. tangent: 0 is any.
void glbk_write_surface(vec3 place, vec3 n, vec3 flat_n, vec3 tangent, uvec4 numbers, uvec4 lobes, vec3 diffuse,
                        vec4 gloss, vec3 map, float occlusion)
{
    if (numbers.x == 2u) gloss.xyz *= map;                  // Phong
    if (numbers.x == 4u) gloss.xy *= map.zy;                // as in glTF: roughness in g, metallic in b
    uint shade = uint(clamp(occlusion, 0.0, 1.0) * 65535.0 + 0.5);
    glbk_out_place = uvec4(floatBitsToUint(place), numbers.y);
    glbk_out_normal = uvec4(floatBitsToUint(n), numbers.x | (numbers.z << 8) | (shade << 16));
    glbk_out_color = uvec4(floatBitsToUint(diffuse), glbk_pack_unit(flat_n));
    glbk_out_gloss = numbers.x == 3u ? uvec4(lobes.xy, glbk_pack_unit(tangent), 0u) : floatBitsToUint(gloss);
}
