// envsh_access - defines what envsh_visible asks of a program, by what glbk_envsh_bind binds.
// uses: table envsh_bindings
#ifndef ENVSH_RGBA
#error "ENVSH_RGBA: 1 where four maps share a texel (glbk_envsh_maps_desc.rgba), else 0"
#endif
#ifndef ENVSH_TEXEL
#define ENVSH_TEXEL(i) texelFetch(glbk_envsh_views, glbk_table_at(i), 0)
#endif
#define ENVSH_CHANNELS (ENVSH_RGBA == 1 ? 4u : 1u)      // maps that share a texel
#define ENVSH_STORED(view, at) envsh_stored(view.light, view.place, at)
#define ENVSH_CELL(view, at, level) envsh_cell(view.light, view.place, at, level)

// Returns column and row of a tile in its page.
ivec2 envsh_slot(uint place) { return ivec2(uvec2(place & 2047u, (place >> 11) & 2047u)); }

// Returns the depth at a texel of the tile of a light.
float envsh_stored(uint light, uint place, ivec2 at)
{
    ivec3 texel = ivec3(envsh_slot(place) * int(glbk_envsh_scene.map_side) + at, int(place >> 22));
#if ENVSH_RGBA
    return uintBitsToFloat(texelFetch(glbk_envsh_depth4, texel, 0)[light & 3u]);
#else
    return texelFetch(glbk_envsh_depth, texel, 0).x;
#endif
}

// Returns least and greatest depth of a cell of the tile of a light.
vec2 envsh_cell(uint light, uint place, ivec2 at, int level)
{
    int layer = int((place >> 22) * ENVSH_CHANNELS + (light & (ENVSH_CHANNELS - 1u)));
    ivec2 corner = envsh_slot(place) * (int(glbk_envsh_scene.cells_side) >> level);
    return uintBitsToFloat(texelFetch(glbk_envsh_cells, ivec3(corner + at, layer), level).xy);
}
