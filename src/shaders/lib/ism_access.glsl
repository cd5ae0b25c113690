// ism_access - VPLs and the texels of their tiles, from what glbk_ism_bind binds.
// uses: table ism_map ism_bindings
struct ism_vpl {
    vec3  position, normal, flux, axis;
    float exponent, side;       // of the lobe; of the square that it stands for
    float reach;                // within which near points take its place; 0 where there are none
    bool  sky;                  // position is the direction to it
    uint  window;               // of its tile
    mat3  frame;                // of its map: columns x, y, z
};

ism_vpl ism_read_vpl(uint v)
{
    ism_vpl l;
    vec4 a = texelFetch(glbk_ism_vpls, glbk_table_at(4u * v), 0), b = texelFetch(glbk_ism_vpls, glbk_table_at(4u * v + 1u), 0);
    vec4 c = texelFetch(glbk_ism_vpls, glbk_table_at(4u * v + 2u), 0), d = texelFetch(glbk_ism_vpls, glbk_table_at(4u * v + 3u), 0);
    l.position = a.xyz;
    l.sky = a.w < 0.0;
    l.exponent = l.sky ? 1.0 : a.w;
    l.normal = b.xyz;
    l.side = b.w;
    l.flux = c.xyz;
    l.reach = glbk_ism_frame.near_points.x > 0u ? c.w : 0.0;
    l.axis = l.exponent != 1.0 ? d.xyz : l.normal;
    l.window = uint(d.w);
    l.frame = ism_frame_of(ism_projection_of(l.exponent) == ISM_PROJECTION_LOBE && !l.sky ? l.axis : l.normal);
    return l;
}

// Where a tile begins in the atlas, and its number.
ivec2 ism_tile_at(uint v)
{
    uint tiles = glbk_ism_frame.maps.z;
    return ivec2(v % tiles, v / tiles) * int(glbk_ism_frame.maps.y);
}

uint ism_tile_of(ivec2 at)
{
    ivec2 tile = at / int(glbk_ism_frame.maps.y);
    return uint(tile.y) * glbk_ism_frame.maps.z + uint(tile.x);
}

// Places of the square in texels of a tile, and back.
vec2 ism_to_tile(uint window, vec2 uv)
{
    uint size = glbk_ism_frame.maps.y;
    return window == 0u ? uv * float(size) : ism_zoom(window, size, uint(glbk_ism_frame.values.y), uv);
}

vec2 ism_from_tile(uint window, vec2 at)
{
    uint size = glbk_ism_frame.maps.y;
    return window == 0u ? at / float(size) : ism_unzoom(window, size, uint(glbk_ism_frame.values.y), at);
}

// What the texels of a tile depend on: x the VPL's exponent or -1 for a sky, y its window.
vec2 ism_kind_of(ism_vpl l) { return vec2(l.sky ? -1.0 : l.exponent, float(l.window)); }

vec2 ism_kind(uint v)
{
    return vec2(texelFetch(glbk_ism_vpls, glbk_table_at(4u * v), 0).w,
                texelFetch(glbk_ism_vpls, glbk_table_at(4u * v + 3u), 0).w);
}

// Direction of a texel's centre in the tile's frame, of a sky its place.
vec3 ism_texel_direction(vec2 kind, ivec2 texel)
{
    uint window = uint(kind.y);
    vec2 uv = ism_from_tile(window, vec2(texel) + 0.5);
    if (kind.x < 0.0) return vec3(2.0 * uv - 1.0, 1.0);
    if (window != 0u || ism_projection_of(kind.x) == ISM_PROJECTION_LOBE)
        return ism_map_direction(ism_projection_of(kind.x), kind.x, uv);
    return glbk_unpack(texelFetch(glbk_ism_directions, texel, 0)).xyz;
}
