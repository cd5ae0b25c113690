// ism_fill - what the passes of pull and push share.
// uses: ism_access
#define ISM_HOLE 2
#define ISM_LEVELS 3

vec4 ism_surfel_at(ivec2 at) { return glbk_unpack(texelFetch(glbk_ism_surfels, at, 0)); }

// Which of the four quadrants about a texel something lies in; each owns one half axis.
uint ism_quadrant(ivec2 d)
{
    return d.x > 0 && d.y >= 0 ? 1u : d.x <= 0 && d.y > 0 ? 2u : d.x < 0 ? 4u : 8u;
}

bool ism_three_quadrants(uint q)
{
    uint missing = ~q & 15u;
    return (missing & (missing - 1u)) == 0u;
}

// Of a cell of 2^level texels a side, by its place in the tile, and 1 + the indices of one texel of each of its four
// parts (0: none): the nearest to its middle. A part of level 1 is a texel, and not 0 where it keeps its surfel.
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
