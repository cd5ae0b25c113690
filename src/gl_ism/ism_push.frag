// Draws the depth of a texel, as bits: the depth of its surfel, or one from other texels about it.
// uses: ism_push ism_pulled
// with: screen.vert
// sets: ISM_PROJECTION=1 | ISM_PROJECTION=4
layout(location = 0) out uint result;

void main()
{
    ivec2 at = ISM_HERE, from;
    uint v = ism_tile_of(at);
    float depth = ISM_FAR;
    bool fills = ISM_F.fill_levels != 0u && v < ISM_F.vpl_count;
    if (texelFetch(glbk_ism_below, at, 0).x != 0u) depth = ism_plane_at(at).w;
    else if (fills) depth = ism_filled(ism_read_grid(v), at, from);
    result = floatBitsToUint(depth);
}
