// cohsm_lookup - one stored depth of a csm block (docs/csm-format.md), read from a texture of its words as they are.
//
// COHSM_TEXEL(i): the including program's uvec4 of words 4 i .. 4 i + 3; i (uint) counts through all blocks that were
// uploaded. What a query needs of the header is read once by cohsm_open; keep the result.
#ifndef COHSM_TEXEL
#error "cohsm_lookup.glsl needs COHSM_TEXEL(i), the uvec4 at texel i of the blocks"
#endif

#define COHSM_DOMAIN_LATLONG 1u
#define COHSM_DOMAIN_OCTAHEDRAL 2u
#define COHSM_DOMAIN_DISC 5u
#define COHSM_DOMAIN_SPHERE 6u
#define COHSM_DOMAIN_TABLE 8u
#define COHSM_DOMAIN_LIST 9u
#define COHSM_ORDER_ZIGZAG 2u
#define COHSM_ORDER_ZIGZAG_THETA 3u
#define COHSM_ORDER_HILBERT 4u
#define COHSM_FRAME_POLAR 1u
#define COHSM_FRAME_MINIMAL 2u

struct cohsm_maps {
    uint  base;                     // texel of the first word
    uint  domain, order, frame;
    uvec3 side;
    uint  map_count, map_size, depth_top, dimensions;
    bool  positional;
    uint  pixel_begin, pixel_end;
    uint  order_at, locations_at, lookup_at, directories_at, lines_at;      // words from the first one
    vec3  center;
    float radius, depth_far;
};

cohsm_maps cohsm_open(uint base)
{
    cohsm_maps m;
    uvec4 kinds = COHSM_TEXEL(base + 1u), sides = COHSM_TEXEL(base + 2u), sizes = COHSM_TEXEL(base + 3u);
    uvec4 range = COHSM_TEXEL(base + 4u), lengths = COHSM_TEXEL(base + 5u), rest = COHSM_TEXEL(base + 6u);
    uvec4 sphere = COHSM_TEXEL(base + 7u);
    m.base = base;
    m.domain = kinds.x;
    m.order = kinds.z;
    m.frame = kinds.w;
    m.side = sides.xyz;
    m.map_count = sides.w;
    m.map_size = sizes.y;
    m.depth_top = (1u << sizes.z) - 1u;
    m.dimensions = sizes.w;
    m.positional = range.x != 0u;
    m.pixel_begin = range.z;
    m.pixel_end = range.w;
    m.order_at = 96u;
    m.locations_at = m.order_at + lengths.x;
    m.lookup_at = m.locations_at + lengths.y;
    m.directories_at = m.lookup_at + lengths.z;
    m.lines_at = m.directories_at + lengths.w;
    m.center = vec3(uintBitsToFloat(rest.w), uintBitsToFloat(sphere.xy));
    m.radius = uintBitsToFloat(sphere.z);
    m.depth_far = uintBitsToFloat(sphere.w);
    return m;
}

uint cohsm_pick(uvec4 t, uint i)
{
    return (i & 2u) != 0u ? ((i & 1u) != 0u ? t.w : t.z) : ((i & 1u) != 0u ? t.y : t.x);
}

uint cohsm_word(cohsm_maps m, uint i) { return cohsm_pick(COHSM_TEXEL(m.base + (i >> 2)), i); }
vec3 cohsm_floats(cohsm_maps m, uint i)
{
    return uintBitsToFloat(uvec3(cohsm_word(m, i), cohsm_word(m, i + 1u), cohsm_word(m, i + 2u)));
}

// Half word h of those that begin at word i.
uint cohsm_half_word(cohsm_maps m, uint i, uint h)
{
    return (cohsm_word(m, i + (h >> 1)) >> (16u * (h & 1u))) & 0xffffu;
}

// A field of at most 16 bits of the bit string that begins at word i.
uint cohsm_bits(cohsm_maps m, uint i, uint bit, uint count)
{
    uint at = i + (bit >> 5), shift = bit & 31u;
    uvec4 t = COHSM_TEXEL(m.base + (at >> 2));
    uint x = cohsm_pick(t, at) >> shift;
    if (shift + count > 32u)
        x |= ((at & 3u) == 3u ? COHSM_TEXEL(m.base + (at >> 2) + 1u).x : cohsm_pick(t, at + 1u)) << (32u - shift);
    return x & ((1u << count) - 1u);
}

uint cohsm_popcount(uint x)
{
    x -= (x >> 1) & 0x55555555u;
    x = (x & 0x33333333u) + ((x >> 2) & 0x33333333u);
    x = (x + (x >> 4)) & 0x0f0f0f0fu;
    return (x * 0x01010101u) >> 24;
}

// Position of the one with this number (from 0) in x; number < count of ones. Halving by counts of ever smaller parts.
uint cohsm_select(uint x, uint number)
{
    uint two = x - ((x >> 1) & 0x55555555u);
    uint four = (two & 0x33333333u) + ((two >> 2) & 0x33333333u);
    uint eight = (four + (four >> 4)) & 0x0f0f0f0fu;
    uint at = 0u, n = (eight + (eight >> 8)) & 0xffu;
    if (number >= n) { number -= n; at = 16u; }
    n = (eight >> at) & 15u;
    if (number >= n) { number -= n; at += 8u; }
    n = (four >> at) & 7u;
    if (number >= n) { number -= n; at += 4u; }
    n = (two >> at) & 3u;
    if (number >= n) { number -= n; at += 2u; }
    n = (x >> at) & 1u;
    return number >= n ? at + 1u : at;
}

// The marks of a block: ones are segments, zeros ends of buckets.
uvec2 cohsm_marks(uint w0, uint w1, uint w2) { return uvec2((w0 >> 16) | (w1 << 16), (w1 >> 16) | (w2 << 16)); }

// Position after the zero with this number.
uint cohsm_after_zero(uvec2 marks, uint number)
{
    uvec2 zeros = ~marks;
    uint low = cohsm_popcount(zeros.x);
    if (number < low) return cohsm_select(zeros.x, number) + 1u;
    return cohsm_select(zeros.y, number - low) + 33u;
}

// 16-bit depth of a grid value; the last one and above are infinite.
uint cohsm_grid_depth(cohsm_maps m, uint g) { return g >= m.depth_top ? 65535u : g * 65535u / m.depth_top; }

// The segment of the block at word b that holds a view, counted from the block's first.
uint cohsm_segment(cohsm_maps m, uint b, uint head, uvec2 marks, uint view)
{
    uint k = (head >> 8) & 15u, bucket = view >> k, low = view & ((1u << k) - 1u);
    uint at = bucket > 0u ? cohsm_after_zero(marks, bucket - 1u) : 0u, j = at - bucket;
    while (at < 64u && (((at < 32u ? marks.x : marks.y) >> (at & 31u)) & 1u) != 0u &&
           cohsm_bits(m, b, 80u + j * k, k) <= low) {
        at++;
        j++;
    }
    return j - 1u;
}

// Depth of segment j of the block at word b.
uint cohsm_segment_depth(cohsm_maps m, uint b, uint head, uvec2 marks, uint j)
{
    uint n = cohsm_popcount(marks.x) + cohsm_popcount(marks.y), k = (head >> 8) & 15u, bits = (head >> 12) & 15u;
    uint base = head & 255u, codes = 80u + n * k;
    bool palette = bits > 9u;
    if (palette) bits -= 9u;
    uint code = cohsm_bits(m, b, codes + j * bits, bits), ones = (1u << bits) - 1u;
    if (code == ones) {
        uint rank = 0u;
        for (uint i = 0u; i < min(j, 64u); i++) rank += cohsm_bits(m, b, codes + i * bits, bits) == ones ? 1u : 0u;
        return cohsm_bits(m, b, codes + n * bits + (palette ? 8u * base : 0u) + 16u * rank, 16u);
    }
    if (palette) return cohsm_grid_depth(m, cohsm_bits(m, b, codes + n * bits + 8u * code, 8u));
    return code + 1u == ones ? 65535u : cohsm_grid_depth(m, base + code);
}

// Stored 16-bit depth of a pixel (less pixel_begin) in the view with this place in the sequence.
// C twin: cohsm__stored_depth, public as cohsm_depths.
uint cohsm_stored_depth(cohsm_maps m, uint pixel, uint place)
{
    uint entry = cohsm_word(m, m.lookup_at + (place >> 16) * (m.pixel_end - m.pixel_begin) + pixel);
    if ((entry & 0x80000000u) != 0u) return entry & 0xffffu;
    uint d = m.directories_at + entry, line = cohsm_word(m, d), count = cohsm_word(m, d + 1u), tail = count >> 16;
    uint view = place & 0xffffu, lo = 0u, hi, first = 0u;
    count &= 0xffffu;
    hi = count;
    while (hi - lo > 1u) {
        uint middle = (lo + hi) >> 1, begin = cohsm_half_word(m, d, middle + 3u);
        if (begin <= view) {
            lo = middle;
            first = begin;
        } else
            hi = middle;
    }
    uint b = m.lines_at + (lo + 1u < count ? 16u * (line + lo) : 16u * (line - (tail >> 4)) + (tail & 15u));
    uint head = cohsm_word(m, b);
    uvec2 marks = cohsm_marks(head, cohsm_word(m, b + 1u), cohsm_word(m, b + 2u));
    return cohsm_segment_depth(m, b, head, marks, cohsm_segment(m, b, head, marks, view - first));
}
