// ism_fill - has functions of the passes that find and fill holes.
// uses: ism_access
#define ISM_HOLE 2          // texels to each side in which a hole looks for surfels before it

// Returns plane and depth of the nearest surfel of a texel of the atlas.
vec4 ism_plane_at(ivec2 at) { return glbk_unpack(texelFetch(glbk_ism_planes, at, 0)); }

// Returns in which of the four quadrants about a texel an offset lies, as a bit. Each quadrant owns one half
// axis.
uint ism_quadrant(ivec2 d)
{
    return d.x > 0 && d.y >= 0 ? 1u : d.x <= 0 && d.y > 0 ? 2u : d.x < 0 ? 4u : 8u;
}

// Returns in which of eight sectors about a texel an offset lies, as a bit. The sectors are 45 degrees wide,
// about the axes and the diagonals.
uint ism_sector(ivec2 d)
{
    ivec2 a = abs(d);
    if (12 * a.y < 5 * a.x) return d.x > 0 ? 1u : 16u;     // about tan 22.5 degrees
    if (12 * a.x < 5 * a.y) return d.y > 0 ? 4u : 64u;
    return d.x > 0 ? (d.y > 0 ? 2u : 128u) : d.y > 0 ? 8u : 32u;
}

// Returns sectors turned by a number of places.
uint ism_turn(uint sectors, int by) { return (sectors << by | sectors >> (8 - by)) & 255u; }

// Returns whether a texel is surrounded, if texels were found in these sectors about it. Texels on one side
// of a line touch five sectors at most. Sectors beyond the tile's border count if texels were found along the
// border on both sides: in the sector along the border or, among close texels, in the next one.
bool ism_surrounded(uint found, uint close, uint beyond)
{
    uint along = (ism_turn(beyond, 1) | ism_turn(beyond, 7)) & ~beyond;
    if (((found | ism_turn(close, 1) | ism_turn(close, 7)) & along) == along) found |= beyond;
    uint open = ~found & 255u;
    return (open & ism_turn(open, 1) & ism_turn(open, 2)) == 0u;
}

// Returns the texel of a cell that is nearest to the cell's middle, as 1 + its index in the tile, or 0 if
// there is none. The cell has 2^level texels a side; `cell` is its place in the tile. Each of its four parts
// has one texel, as 1 + index, or 0 for none. A part of level 1 is a texel, and not 0 if the texel keeps its
// surfel.
uint ism_pull(int level, ivec2 cell, uvec4 parts)
{
    int size = int(ISM_F.tile_side), least = 0x7fffffff;
    ivec2 middle = (2 * cell + 1) << level;
    uint result = 0u;
    for (int k = 0; k < 4; k++) {
        ivec2 texel = 2 * cell + ivec2(k & 1, k >> 1);
        int at = int(parts[k]);
        if (at == 0) continue;
        if (level == 1) at = texel.y * size + texel.x + 1;
        ivec2 d = 2 * ivec2((at - 1) % size, (at - 1) / size) + 1 - middle;
        if (d.x * d.x + d.y * d.y < least) {
            least = d.x * d.x + d.y * d.y;
            result = uint(at);
        }
    }
    return result;
}
