// gbuffer - what one pixel of the G-buffer holds: four RGBA32UI textures, floats as their bits (docs/gpu-layouts.md).
// uses: gbuffer_bindings gbuffer_pack
#define GLBK_LAMBERT 1u             // the numbers of lsamp_material_kind
#define GLBK_PHONG 2u
#define GLBK_LAFORTUNE 3u
#define GLBK_METAL_ROUGH 4u

struct glbk_point {
    vec3 position, normal;          // world; the unit shading normal, on the side that is seen
    vec3 geometric;                 // unit, the surface's own, on that side too
    vec3 tangent;                   // unit, of Lafortune's lobes; 0: any
    uint kind;                      // GLBK_LAMBERT to GLBK_METAL_ROUGH; 0: nothing is seen
    vec3 diffuse;                   // albedo; metal-rough: the base colour
    vec3 specular;                  // Phong, else 0
    float exponent;                 // Phong, else 0
    float metallic, roughness;      // metal-rough, else 0
    uint lobe, lobe_count;          // Lafortune: the first one, and how many; else 0
    float occlusion;                // of bounced light: 0 open .. 1 none of it comes
    uint entity;                    // that the point lies on, from 1; 0: none
    uint plane;                     // receiver plane that it lies on, from 1; 0: none
};

// false: nothing is seen there. What a shader does not use of the result costs nothing: drivers leave out its fetches.
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
