// Draws what the maps show as VPLs that might be, the source of the next bounce (imperfect reflective shadow maps):
// one in the middle of each cell of a VPL's tile, a row a VPL. Three pictures: place; normal; flux.
// uses: ism_push ism_pulled ism_corners
// with: screen.vert
// sets: ISM_PROJECTION=1 | ISM_PROJECTION=2
layout(location = 0) out uvec4 place;
layout(location = 1) out uvec4 facing;
layout(location = 2) out uvec4 power;

vec3 ism_beside(ism_vpl l, ivec2 texel, float x, float y)
{
    vec2 uv = (vec2(texel) + 0.5 + vec2(x, y)) / float(ISM_F.tile_side);
    return ism_map_direction(uint(ISM_PROJECTION), l.exponent, uv);
}

// Returns how much of a VPL's light leaves through a cell, but for a factor: intensity x solid angle. All cells of
// COSINE and LOBE maps are equal.
float ism_cell_weight(ism_vpl l, ivec2 texel)
{
    float weight = 1.0;
#if ISM_PROJECTION == 2 || ISM_PROJECTION == 3
    vec3 d = ism_beside(l, texel, -0.25, -0.25);
    vec3 n = cross(ism_beside(l, texel, 0.25, 0.25) - d,
                   ism_beside(l, texel, -0.25, 0.25) - ism_beside(l, texel, 0.25, -0.25));
    weight = 0.0;
    if (d.z > 0.0) weight = length(n) * cohsm_pow(d.z, l.exponent);
#endif
    return weight;
}

// Returns the middle texel of a cell.
ivec2 ism_cell_texel(int cell, int side, int step) { return ivec2(cell % side, cell / side) * step + step / 2; }

void main()
{
    ivec2 at = ISM_HERE;
    int side = int(ISM_F.bounce_side), step = int(ISM_F.tile_side) / side;
    place = facing = power = uvec4(0u);
    uint v = uint(at.y);
    if (v >= ISM_F.vpl_count) return;
    facing.y = 0x3f800000u;                     // 1.0
    ism_vpl l = ism_read_vpl(v);
    ivec2 texel = ism_cell_texel(at.x, side, step), to = ism_tile_at(v) + texel, from = to;
    float sum = 0.0, share = ism_cell_weight(l, texel);
    for (int k = 0; k < side * side; k++) sum += ism_cell_weight(l, ism_cell_texel(k, side, step));
    bool hit = texelFetch(glbk_ism_below, to, 0).x != 0u;
    if (!hit) hit = ism_filled(l.grid, to, from) < ISM_FAR;
    vec3 w = ism_texel_direction(l.grid, texel);
    if (l.sky || !hit || !(w.z > 0.0)) return;
    uint t = texelFetch(glbk_ism_hits, from, 0).x;
    vec3 n = ism_normal2(ism_read_corners(t)), d = l.basis * w;
    float size = length(n);
    if (!(size > 0.0) || !cohsm_finite(size)) return;
    if (dot(n, d) > 0.0) size = -size;
    d = l.position + d * ISM_FLOATS(glbk_ism_atlas, to).x;
    l.flux *= share / sum * texelFetch(glbk_ism_albedos, glbk_table_at(t), 0).xyz;
    place = floatBitsToUint(vec4(d, 0.0));
    facing = floatBitsToUint(vec4(n / size, 0.0));
    power = floatBitsToUint(vec4(l.flux, 0.0));
}
