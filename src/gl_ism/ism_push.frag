// Draws the depth of a texel, as bits: the depth of its surfel, or one from other texels about it.
// uses: ism_push
// with: screen.vert
// sets: ISM_PROJECTION=1 | ISM_PROJECTION=4
layout(location = 0) out uint result;

int ism_pulled(int level, ivec2 cell)
{
    if (level == 1) return int(texelFetch(glbk_ism_pull1, cell, 0).x);
    if (level == 2) return int(texelFetch(glbk_ism_pull2, cell, 0).x);
    return int(texelFetch(glbk_ism_pull3, cell, 0).x);
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    uint v = ism_tile_of(at);
    float depth = ISM_FAR;
    bool fills = glbk_ism_frame.fill_levels != 0u && v < glbk_ism_frame.vpl_count;
    if (texelFetch(glbk_ism_below, at, 0).x != 0u) depth = ism_plane_at(at).w;
    else if (fills) depth = ism_filled(ism_read_grid(v), at);
    result = floatBitsToUint(depth);
}
