// ism_access - reads VPLs and finds the texels of their tiles, by what glbk_ism_bind binds.
// uses: table ism_map ism_floats
// ISM_TEXEL reads texel i of the table of VPLs, whose floats are kept as their bits: so every GL can draw it.
#define ISM_F glbk_ism_frame            // short, since 60 places name it
#define ISM_TEXEL(i) ISM_FLOATS(glbk_ism_vpls, glbk_table_at(i))

struct ism_grid {               // what the texels of a tile depend on
    float exponent;             // of the VPL's lobe; -1 = a sky's VPL
    vec4  across, down;         // the axes of the tile, by ism_axis
};

struct ism_vpl {
    vec3  position;             // of a sky's VPL: the unit direction to it
    vec3  normal;               // of the surface that the VPL lies on
    vec3  flux;                 // W
    vec3  axis;                 // of its lobe
    float exponent;             // of its lobe
    float edge;                 // of the square that the VPL stands for
    float reach;                // distance within which near points take the VPL's place; 0 = none do
    bool  sky;                  // whether the VPL is directional
    uint  window;               // of its tile
    ism_grid grid;
    mat3  basis;                // of its map, as columns x, y, z
};

// Returns the grid of a tile, by its VPL's exponent (-1 for a sky's VPL) and window.
ism_grid ism_grid_of(float exponent, uint window)
{
    ism_grid g;
    g.exponent = exponent;
    ism_axes(window, ISM_F.tile_side, ISM_F.window_rim, g.across, g.down);
    return g;
}

// Reads a VPL from the table.
ism_vpl ism_read_vpl(uint v)
{
    ism_vpl l;
    vec4 a = ISM_TEXEL(4u * v), b = ISM_TEXEL(4u * v + 1u);
    vec4 c = ISM_TEXEL(4u * v + 2u), d = ISM_TEXEL(4u * v + 3u);
    l.position = a.xyz;
    l.sky = a.w < 0.0;
    l.exponent = l.sky ? 1.0 : a.w;
    l.normal = b.xyz;
    l.edge = b.w;
    l.flux = c.xyz;
    l.reach = ISM_F.near_point_count > 0u ? c.w : 0.0;
    l.axis = l.exponent != 1.0 ? d.xyz : l.normal;
    l.window = uint(d.w);
    l.grid = ism_grid_of(a.w, l.window);
    bool about_axis = ism_projection_of(l.exponent) == ISM_PROJECTION_LOBE && !l.sky;
    l.basis = ism_basis_of(about_axis ? l.axis : l.normal);
    return l;
}

// Returns the texel at which the tile of a VPL begins in the atlas.
ivec2 ism_tile_at(uint v)
{
    uint tiles = ISM_F.tiles_across;
    uint row = uint((float(v) + 0.5) / float(tiles));       // divided as floats: see ism_axis
    return ivec2(v - row * tiles, row) * int(ISM_F.tile_side);
}

// Returns the number of the VPL in whose tile a texel of the atlas lies.
uint ism_tile_of(ivec2 at)
{
    ivec2 tile = at / int(ISM_F.tile_side);
    return uint(tile.y) * ISM_F.tiles_across + uint(tile.x);
}

// Returns the place in a tile, in texels, of a place on the unit square of its map.
vec2 ism_to_tile(ism_grid g, vec2 uv)
{
    float size = float(ISM_F.tile_side), rim = float(ISM_F.window_rim);
    return vec2(ism_zoom_axis(g.across, size, rim, uv.x), ism_zoom_axis(g.down, size, rim, uv.y));
}

// Returns the place on the unit square of a place in a tile, in texels.
vec2 ism_from_tile(ism_grid g, vec2 at)
{
    float size = float(ISM_F.tile_side), rim = float(ISM_F.window_rim);
    return vec2(ism_unzoom_axis(g.across, size, rim, at.x), ism_unzoom_axis(g.down, size, rim, at.y));
}

// Reads the grid of a VPL's tile, without the rest of the VPL.
ism_grid ism_read_grid(uint v)
{
    return ism_grid_of(ISM_TEXEL(4u * v).w, uint(ISM_TEXEL(4u * v + 3u).w));
}

// Returns the direction of a texel's centre in the tile's space, or in the map of a sky the centre's place on
// the square -1..1.
vec3 ism_texel_direction(ism_grid g, ivec2 texel)
{
    vec2 uv = ism_from_tile(g, vec2(texel) + 0.5);
    if (g.exponent < 0.0) return vec3(2.0 * uv - 1.0, 1.0);
    return ism_map_direction(ism_projection_of(g.exponent), g.exponent, uv);
}
