// The depth of a texel, as bits: its surfel's, or from others about it.
// uses: ism_push
// with: screen.vert
// sets: ISM_PROJECTION=1 | ISM_PROJECTION=4
layout(location = 0) out uint result;

int ism_pulled(int level, ivec2 cell)
{
    uint at = level == 1 ? texelFetch(glbk_ism_pull1, cell, 0).x : level == 2 ? texelFetch(glbk_ism_pull2, cell, 0).x
                                                                              : texelFetch(glbk_ism_pull3, cell, 0).x;
    return int(at);
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    uint v = ism_tile_of(at);
    float depth = ISM_FAR;
    if (texelFetch(glbk_ism_below, at, 0).x != 0u) depth = ism_surfel_at(at).w;
    else if (glbk_ism_frame.points.z != 0u && v < glbk_ism_frame.maps.x) depth = ism_filled(ism_read_grid(v), at);
    result = floatBitsToUint(depth);
}
