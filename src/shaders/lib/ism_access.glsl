// ism_access - VPLs and the texels of their tiles, from what glbk_ism_bind binds.
// uses: table ism_map ism_bindings
struct ism_vpl {
    vec3  position, normal, flux, axis;
    float exponent, side;       // of the lobe; of the square that it stands for
    float reach;                // within which near points take its place; 0 where there are none
    bool  sky;                  // position is the direction to it
    mat3  frame;                // of its map: columns x, y, z
};

ism_vpl ism_read_vpl(uint v)
{
    ism_vpl l;
    vec4 a = texelFetch(glbk_ism_vpls, glbk_table_at(4u * v), 0), b = texelFetch(glbk_ism_vpls, glbk_table_at(4u * v + 1u), 0);
    vec4 c = texelFetch(glbk_ism_vpls, glbk_table_at(4u * v + 2u), 0);
    l.position = a.xyz;
    l.sky = a.w < 0.0;
    l.exponent = l.sky ? 1.0 : a.w;
    l.normal = b.xyz;
    l.side = b.w;
    l.flux = c.xyz;
    l.reach = glbk_ism_frame.near_points.x > 0u ? c.w : 0.0;
    l.axis = l.normal;
    if (l.exponent != 1.0) l.axis = texelFetch(glbk_ism_vpls, glbk_table_at(4u * v + 3u), 0).xyz;
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

// Direction of a texel's centre in the tile's frame. kind: a VPL's exponent, or -1 for a sky, where it is a place.
vec3 ism_texel_direction(float kind, ivec2 texel)
{
    vec2 uv = (vec2(texel) + 0.5) / float(glbk_ism_frame.maps.y);
    if (kind < 0.0) return vec3(2.0 * uv - 1.0, 1.0);
    if (ism_projection_of(kind) == ISM_PROJECTION_LOBE) return ism_map_direction(ISM_PROJECTION_LOBE, kind, uv);
    return glbk_unpack(texelFetch(glbk_ism_directions, texel, 0)).xyz;
}

float ism_kind(uint v) { return texelFetch(glbk_ism_vpls, glbk_table_at(4u * v), 0).w; }
