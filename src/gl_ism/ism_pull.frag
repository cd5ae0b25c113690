// Draws a cell of 2^ISM_LEVEL texels a side: 1 + the index, in its tile, of one texel of its four parts.
// uses: ism_fill
// with: screen.vert
// sets: ISM_LEVEL=1 | ISM_LEVEL=2 | ISM_LEVEL=3
#ifndef ISM_LEVEL
#define ISM_LEVEL 1
#endif
layout(location = 0) out uint result;

void main()
{
    ivec2 cell = ISM_HERE;
    uvec4 parts;
    for (int k = 0; k < 4; k++) parts[k] = texelFetch(glbk_ism_below, 2 * cell + ivec2(k & 1, k >> 1), 0).x;
    result = ism_pull(ISM_LEVEL, cell & ((int(ISM_F.tile_side) >> ISM_LEVEL) - 1), parts);
}
