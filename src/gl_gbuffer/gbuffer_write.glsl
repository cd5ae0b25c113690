// gbuffer_write - writes a pixel of the G-buffer: glbk_read_point reads what glbk_write_point was given.
// uses: gbuffer_pack
layout(location = 0) out uvec4 glbk_out_place;
layout(location = 1) out uvec4 glbk_out_normal;
layout(location = 2) out uvec4 glbk_out_color;
layout(location = 3) out uvec4 glbk_out_gloss;

// Sets what the material says besides its kind and colour: numbers of the block, times a gloss map's colour
// or 1.
void glbk_set_gloss(inout glbk_point p, vec4 numbers, vec3 map)
{
    p.specular = numbers.xyz * map;         // Phong
    p.exponent = numbers.w;
    p.metallic = numbers.x * map.z;         // metal-rough, as in glTF: metallic in b, roughness in g
    p.roughness = numbers.y * map.y;
}

// Writes a pixel.
void glbk_write_point(glbk_point p)
{
    uint shade = uint(clamp(p.occlusion, 0.0, 1.0) * 65535.0 + 0.5);
    glbk_out_place = uvec4(floatBitsToUint(p.position), p.entity);
    glbk_out_normal = uvec4(floatBitsToUint(p.normal), p.kind | (p.plane << 8) | (shade << 16));
    glbk_out_color = uvec4(floatBitsToUint(p.diffuse), glbk_pack_unit(p.geometric));
    glbk_out_gloss = uvec4(0u);
    if (p.kind == GLBK_PHONG) glbk_out_gloss = floatBitsToUint(vec4(p.specular, p.exponent));
    if (p.kind == GLBK_METAL_ROUGH) glbk_out_gloss.xy = floatBitsToUint(vec2(p.metallic, p.roughness));
    if (p.kind == GLBK_LAFORTUNE) glbk_out_gloss = uvec4(p.lobe, p.lobe_count, glbk_pack_unit(p.tangent), 0u);
}
