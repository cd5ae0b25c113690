// ism_fill - what the passes of pull and push share.
// uses: ism_access
#define ISM_HOLE 2
#define ISM_LEVELS 3

vec4 ism_plane_at(ivec2 at) { return glbk_unpack(texelFetch(glbk_ism_planes, at, 0)); }

// Which of the four quadrants about a texel something lies in; each owns one half axis.
uint ism_quadrant(ivec2 d)
{
    return d.x > 0 && d.y >= 0 ? 1u : d.x <= 0 && d.y > 0 ? 2u : d.x < 0 ? 4u : 8u;
}

// Which of eight sectors about a texel, of 45 degrees each about the axes and diagonals.
uint ism_sector(ivec2 d)
{
    ivec2 a = abs(d);
    if (12 * a.y < 5 * a.x) return d.x > 0 ? 1u : 16u;                      // tan 22.5 = 5 / 12
    if (12 * a.x < 5 * a.y) return d.y > 0 ? 4u : 64u;
    return d.x > 0 ? (d.y > 0 ? 2u : 128u) : d.y > 0 ? 8u : 32u;
}

uint ism_turn(uint sectors, int by) { return (sectors << by | sectors >> (8 - by)) & 255u; }

// Is a texel with something in these sectors about it surrounded? All that lies on one side of a line touches
// five of them at most. Those beyond the tile's border count where the border has something on both sides of
// the texel: in the sector along it or, of what is close, the next one.
bool ism_surrounded(uint found, uint close, uint beyond)
{
    uint along = (ism_turn(beyond, 1) | ism_turn(beyond, 7)) & ~beyond;
    if (((found | ism_turn(close, 1) | ism_turn(close, 7)) & along) == along) found |= beyond;
    uint open = ~found & 255u;
    return (open & ism_turn(open, 1) & ism_turn(open, 2)) == 0u;
}

// Of a cell of 2^level texels a side, by its place in the tile, and 1 + the indices of one texel of each of
// its four parts (0: none): the nearest to its middle. A part of level 1 is a texel, and not 0 where it keeps
// its surfel.
uint ism_pull(int level, ivec2 cell, uvec4 parts)
{
    int size = int(glbk_ism_frame.maps.y), least = 0x7fffffff;
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
