// csm_compress - layers of a batch of views to segments, for one pixel: equation (1), greedily, as csm.h does.
// uses: csm_bindings

// What goes on from batch to batch. lo, hi: the grid values that the open segment may have; fresh: it has no view yet.
struct csm_open { uint lo, hi; bool fresh; uint next; };

// At most 12 segments end in a run: each is lo, hi << 8 (exact: the depth), exact << 16, the view that it ends before
// << 17.
struct csm_ended { uint count; uvec4 records[3]; };

void csm_end(inout csm_ended ended, uint record)
{
    uint i = ended.count & 3u;
    uvec4 r = uvec4(i == 0u ? record : 0u, i == 1u ? record : 0u, i == 2u ? record : 0u, i == 3u ? record : 0u);
    if (ended.count < 4u) ended.records[0] += r;
    else if (ended.count < 8u) ended.records[1] += r;
    else ended.records[2] += r;
    ended.count++;
}

uint csm_depth16(uint bits)
{
    float z = uintBitsToFloat(bits);
    return z <= 1.0 ? uint(clamp(z * 65533.0, 0.0, 65533.0)) : 65535u;
}

// The interval of depths that separate the layers at one texel of the tiles.
uvec2 csm_interval(ivec2 at)
{
    uint z1 = csm_depth16(texelFetch(glbk_csm_layer0, at, 0).x), upper;
    uvec4 how = glbk_csm_peel.how;              // grid's top; far; positional; self_only
    if (z1 == 65535u) return uvec2(how.w != 0u ? 0u : 65535u, 65535u);
    if (how.y != 0u) {
        upper = csm_depth16(texelFetch(glbk_csm_layer2, at, 0).x);
        if (upper == 65535u) return uvec2(z1, 65535u);
    } else {
        upper = csm_depth16(texelFetch(glbk_csm_layer1, at, 0).x);
        float thickness = glbk_csm_peel.values.z;
        if (upper == 65535u) upper = z1 + 1u + uint(how.z != 0u ? thickness * float(z1) : thickness);
    }
    return uvec2(z1, upper > z1 ? min(upper - 1u, 65534u) : z1);
}

csm_ended csm_compress(ivec2 pixel, inout csm_open o)
{
    uint size = glbk_csm_peel.tiles.x, across = glbk_csm_peel.tiles.y, views = glbk_csm_peel.tiles.z;
    uint top = glbk_csm_peel.how.x;
    csm_ended ended = csm_ended(0u, uvec4[3](uvec4(0u), uvec4(0u), uvec4(0u)));
    for (; o.next < views && ended.count < 11u; o.next++) {
        uvec2 z = csm_interval(pixel + ivec2(uvec2(o.next % across, o.next / across) * size));
        uint lo = (z.x * top + 65534u) / 65535u, hi = ((z.y + 1u) * top - 1u) / 65535u;
        uint both_lo = max(o.lo, lo), both_hi = min(o.hi, hi);
        bool fresh = false;
        if (both_lo > both_hi) {
            if (!o.fresh) csm_end(ended, o.lo | (o.hi << 8) | (o.next << 17));
            both_lo = lo;
            both_hi = hi;
            if (lo > hi) {                      // no value of the grid fits: exact, a segment of its own
                csm_end(ended, ((z.x + z.y) / 2u) | (1u << 16) | ((o.next + 1u) << 17));
                both_lo = 0u;
                both_hi = top;
                fresh = true;
            }
        }
        o.lo = both_lo;
        o.hi = both_hi;
        o.fresh = fresh;
    }
    return ended;
}
