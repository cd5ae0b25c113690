// csm_compress - makes segments of one pixel from the layers of a batch of views: equation (1), greedily, as
// csm.h does.
// uses: csm_bindings

// This is the segment that is open at the end of a run.
struct csm_open {
    uint lo,                        // the least and greatest value of the grid that it may have
         hi;
    bool fresh;                     // it has no view yet
    uint next;                      // the next view of the batch
};

// These are the segments that ended in a run, at most 12. Each is a word: lo | hi << 8, or an exact depth |
// 1 << 16, and << 17 the view before which the segment ends.
struct csm_ended {
    uint count;
    uvec4 records[3];
};

// Adds a record.
void csm_end(inout csm_ended ended, uint record)
{
    uint i = ended.count & 3u;
    uvec4 r = record * uvec4(equal(uvec4(i), uvec4(0u, 1u, 2u, 3u)));
    if (ended.count < 4u) ended.records[0] += r;
    else if (ended.count < 8u) ended.records[1] += r;
    else ended.records[2] += r;
    ended.count++;
}

// Returns a layer's depth in 16 bits; 65535: there is no hit.
uint csm_depth16(uint bits)
{
    float z = uintBitsToFloat(bits);
    return z <= 1.0 ? uint(clamp(z * 65533.0, 0.0, 65533.0)) : 65535u;
}

// Returns the 16-bit depth at which the ray of a pixel of a view leaves the bounding sphere.
uint csm_leave(ivec2 pixel, uint view)
{
    vec2 p = (vec2(pixel) + 0.5) / float(glbk_csm_peel.side) * 2.0 - 1.0;
    if (glbk_csm_peel.positional == 0u) {
        float square = 1.0 - p.x * p.x - p.y * p.y;
        return csm_depth16(floatBitsToUint(0.5 + 0.5 * sqrt(square > 0.0 ? square : 0.0)));
    }
    vec4 e = glbk_csm_peel.eyes[view];
    float a = p.x * p.x + p.y * p.y + 1.0, b = e.x * p.x + e.y * p.y + e.z;
    float c = e.x * e.x + e.y * e.y + e.z * e.z - 1.0, disc = b * b - a * c;
    if (!(disc > 0.0)) return 0u;
    return csm_depth16(floatBitsToUint(clamp((sqrt(disc) - b) / a * e.w, 0.0, 1.0)));
}

// Returns the interval of depths that separate the layers at one texel of the tiles, of a pixel of a view.
uvec2 csm_interval(ivec2 at, ivec2 pixel, uint view)
{
    uint z1 = csm_depth16(texelFetch(glbk_csm_layer0, at, 0).x), upper;
    if (z1 == 65535u) return uvec2(glbk_csm_peel.self_only != 0u ? 0u : 65535u, 65535u);
    if (glbk_csm_peel.far_layer != 0u) {
        upper = csm_depth16(texelFetch(glbk_csm_layer2, at, 0).x);
        if (upper == 65535u && glbk_csm_peel.sphere == 0u) return uvec2(z1, 65535u);
        if (upper == 65535u) {
            upper = csm_depth16(texelFetch(glbk_csm_layer1, at, 0).x);
            upper = max(csm_leave(pixel, view), upper == 65535u ? z1 : upper) + 1u;
        }
    } else {
        upper = csm_depth16(texelFetch(glbk_csm_layer1, at, 0).x);
        float thickness = glbk_csm_peel.open_thickness;
        if (glbk_csm_peel.positional != 0u) thickness *= float(z1);
        if (upper == 65535u) upper = z1 + 1u + uint(thickness);
    }
    return uvec2(z1, upper > z1 ? min(upper - 1u, 65534u) : z1);
}

// Goes on with the open segment of a pixel until the batch or the room for records ends.
csm_ended csm_compress(ivec2 pixel, inout csm_open o)
{
    uint side = glbk_csm_peel.side, across = glbk_csm_peel.tiles_across, top = glbk_csm_peel.depth_top;
    csm_ended ended = csm_ended(0u, uvec4[3](uvec4(0u), uvec4(0u), uvec4(0u)));
    for (; o.next < glbk_csm_peel.view_count && ended.count < 11u; o.next++) {
        uvec2 z = csm_interval(pixel + ivec2(uvec2(o.next % across, o.next / across) * side), pixel, o.next);
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
