// gbuffer - reads a pixel of the G-buffer: four RGBA32UI textures, floats as their bits
// (docs/gpu-layouts.md).
// uses: gbuffer_bindings gbuffer_pack

// Reads the pixel at those coordinates and returns whether anything is seen in it. Members that a shader does
// not use cost nothing: drivers leave out their fetches.
bool glbk_read_point(ivec2 at, out glbk_point p)
{
    uvec4 place = texelFetch(glbk_gbuffer_place, at, 0), normal = texelFetch(glbk_gbuffer_normal, at, 0);
    uvec4 color = texelFetch(glbk_gbuffer_color, at, 0), gloss = texelFetch(glbk_gbuffer_gloss, at, 0);
    vec4 values = uintBitsToFloat(gloss);
    p.kind = normal.w & 0xffu;
    bool phong = p.kind == GLBK_PHONG, metal = p.kind == GLBK_METAL_ROUGH, lobes = p.kind == GLBK_LAFORTUNE;
    p.position = uintBitsToFloat(place.xyz);
    p.entity = place.w;
    p.normal = uintBitsToFloat(normal.xyz);
    p.plane = (normal.w >> 8) & 0xffu;
    p.occlusion = float(normal.w >> 16) / 65535.0;
    p.diffuse = uintBitsToFloat(color.xyz);
    p.geometric = glbk_unpack_unit(color.w);
    p.specular = phong ? values.xyz : vec3(0.0);
    p.exponent = phong ? values.w : 0.0;
    p.metallic = metal ? values.x : 0.0;
    p.roughness = metal ? values.y : 0.0;
    p.lobe = lobes ? gloss.x : 0u;
    p.lobe_count = lobes ? gloss.y : 0u;
    p.tangent = lobes ? glbk_unpack_unit(gloss.z) : vec3(0.0);
    return p.kind != 0u;
}
