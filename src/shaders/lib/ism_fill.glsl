// ism_fill - what the passes of pull and push share.
// uses: ism_access
#define ISM_HOLE 2

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
