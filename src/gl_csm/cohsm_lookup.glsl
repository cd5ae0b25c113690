// cohsm_lookup - one stored depth of a csm block (docs/csm-format.md), read from a texture of its words as they are.
//
// COHSM_TEXEL(i): the including program's uvec4 of words 4 i .. 4 i + 3; i (uint) counts through all blocks that were
// uploaded. What a query needs of the header is read once by cohsm_open; keep the result.
// COHSM_ONE_DOMAIN, COHSM_ONE_ORDER, COHSM_ONE_FRAME: the number that all blocks have there, where they agree; the code
// for others is gone then.
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

// Of texels 1 to 7 of a block.
cohsm_maps cohsm_unpack(uint base, uvec4 kinds, uvec4 sides, uvec4 sizes, uvec4 range, uvec4 lengths, uvec4 rest,
                        uvec4 sphere)
{
    cohsm_maps m;
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
#ifdef COHSM_ONE_DOMAIN
    m.domain = uint(COHSM_ONE_DOMAIN);
#if COHSM_ONE_DOMAIN < 8
    m.positional = COHSM_ONE_DOMAIN > 2;
    m.dimensions = COHSM_ONE_DOMAIN == 3 ? 1u : COHSM_ONE_DOMAIN == 7 ? 3u : 2u;
#endif
#endif
#ifdef COHSM_ONE_ORDER
    m.order = uint(COHSM_ONE_ORDER);
#endif
#ifdef COHSM_ONE_FRAME
    m.frame = uint(COHSM_ONE_FRAME);
#endif
    return m;
}

cohsm_maps cohsm_open(uint base)
{
    return cohsm_unpack(base, COHSM_TEXEL(base + 1u), COHSM_TEXEL(base + 2u), COHSM_TEXEL(base + 3u),
                        COHSM_TEXEL(base + 4u), COHSM_TEXEL(base + 5u), COHSM_TEXEL(base + 6u),
                        COHSM_TEXEL(base + 7u));
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

// ---- lines: the 64 bytes that a block of segments lies in, fetched at once ----

struct cohsm_line {
    uvec4 a, b, c, d;
    uint  bit;                      // of the block's first word
};

cohsm_line cohsm_fetch_line(cohsm_maps m, uint word)
{
    uint i = m.base + (word >> 4 << 2);
    return cohsm_line(COHSM_TEXEL(i), COHSM_TEXEL(i + 1u), COHSM_TEXEL(i + 2u), COHSM_TEXEL(i + 3u),
                      (word & 15u) << 5);
}

uint cohsm_line_word(cohsm_line l, uint i)
{
    return cohsm_pick((i & 8u) != 0u ? ((i & 4u) != 0u ? l.d : l.c) : ((i & 4u) != 0u ? l.b : l.a), i);
}

// count (1..32) bits of the block, from one of its bits on; with count 0, none.
uint cohsm_bits(cohsm_line l, uint bit, uint count)
{
    bit += l.bit;
    uint at = bit >> 5, shift = bit & 31u, x = cohsm_line_word(l, at) >> shift;
    if (shift + count > 32u) x |= cohsm_line_word(l, at + 1u) << (32u - shift);
    return count > 0u ? x & (0xffffffffu >> (32u - count)) : 0u;
}

// The segment of a block that holds a view, counted from the block's first.
uint cohsm_segment(cohsm_line l, uint head, uvec2 marks, uint view)
{
    uint k = (head >> 8) & 15u, bucket = view >> k, low = view & ((1u << k) - 1u);
    uint at = bucket > 0u ? cohsm_after_zero(marks, bucket - 1u) : 0u, j = at - bucket;
    while (at < 64u && (((at < 32u ? marks.x : marks.y) >> (at & 31u)) & 1u) != 0u &&
           cohsm_bits(l, 80u + j * k, k) <= low) {
        at++;
        j++;
    }
    return j - 1u;
}

// How many of the first count codes are all ones. As many as fit into a word are compared at once: one added to a code
// without its highest bit carries into that bit where all others are set.
uint cohsm_escapes(cohsm_line l, uint codes, uint bits, uint count)
{
    uint step = 32u / bits, one = (0xffffffffu >> (32u - step * bits)) / ((1u << bits) - 1u), high = one << (bits - 1u);
    uint rank = 0u;
    for (uint i = 0u; i < count; i += step) {
        uint x = cohsm_bits(l, codes + i * bits, min(step, count - i) * bits);
        rank += cohsm_popcount(((x & ~high) + one) & x & high);
    }
    return rank;
}

// Depth of segment j of a block.
uint cohsm_segment_depth(cohsm_maps m, cohsm_line l, uint head, uvec2 marks, uint j)
{
    uint n = cohsm_popcount(marks.x) + cohsm_popcount(marks.y), k = (head >> 8) & 15u, bits = (head >> 12) & 15u;
    uint base = head & 255u, codes = 80u + n * k;
    bool palette = bits > 9u;
    if (palette) bits -= 9u;
    uint code = cohsm_bits(l, codes + j * bits, bits), ones = (1u << bits) - 1u;
    if (code == ones) {
        uint rank = cohsm_escapes(l, codes, max(bits, 1u), min(j, 64u));
        return cohsm_bits(l, codes + n * bits + (palette ? 8u * base : 0u) + 16u * rank, 16u);
    }
    if (palette) return cohsm_grid_depth(m, cohsm_bits(l, codes + n * bits + 8u * code, 8u));
    return code + 1u == ones ? 65535u : cohsm_grid_depth(m, base + code);
}

// The block of a list that holds a view: its number, and its first view.
uvec2 cohsm_find_block(cohsm_maps m, uint list, uint count, uint view)
{
    uint from = 2u * list + 4u, low = from >> 3, high = (from + count + 6u) >> 3;   // eight first views a texel
    uvec2 found = uvec2(0u);
    while (low < high) {
        uint middle = (low + high) >> 1, i = 8u * middle - from;
        uvec4 t = COHSM_TEXEL(m.base + middle), even = t & 0xffffu, odd = t >> 16;
        uvec4 number = i + uvec4(0u, 2u, 4u, 6u), top = uvec4(count - 1u), asked = uvec4(view);
        even = (even + 1u) * uvec4(lessThan(number, top)) * uvec4(lessThanEqual(even, asked));
        odd = (odd + 1u) * uvec4(lessThan(number + 1u, top)) * uvec4(lessThanEqual(odd, asked));
        uvec4 last = max(even, odd), ones = min(even, 1u) + min(odd, 1u);
        uint first = max(max(last.x, last.y), max(last.z, last.w));     // + 1, or 0: none begins before
        if (first > 0u) {
            found = uvec2((8u * middle < from ? 0u : i) + ones.x + ones.y + ones.z + ones.w, first - 1u);
            low = middle + 1u;
        } else
            high = middle;
    }
    return found;
}

// Stored 16-bit depth of a pixel (less pixel_begin) in the view with this place in the sequence.
// C twin: cohsm__stored_depth, public as cohsm_depths.
uint cohsm_stored_depth(cohsm_maps m, uint pixel, uint place)
{
    uint entry = cohsm_word(m, m.lookup_at + (place >> 16) * (m.pixel_end - m.pixel_begin) + pixel);
    if ((entry & 0x80000000u) != 0u) return entry & 0xffffu;
    uint list = m.directories_at + entry, view = place & 0xffffu;
    uvec4 t = COHSM_TEXEL(m.base + (list >> 2));
    uint first = cohsm_pick(t, list);
    uint count = (list & 3u) == 3u ? COHSM_TEXEL(m.base + (list >> 2) + 1u).x : cohsm_pick(t, list + 1u);
    uint tail = count >> 16;
    count &= 0xffffu;
    uvec2 block = cohsm_find_block(m, list, count, view);
    uint line = block.x + 1u < count ? 16u * (first + block.x) : 16u * (first - (tail >> 4)) + (tail & 15u);
    cohsm_line l = cohsm_fetch_line(m, m.lines_at + line);
    uint at = l.bit >> 5, head = cohsm_line_word(l, at);
    uvec2 marks = cohsm_marks(head, cohsm_line_word(l, at + 1u), cohsm_line_word(l, at + 2u));
    return cohsm_segment_depth(m, l, head, marks, cohsm_segment(l, head, marks, view - block.y));
}
