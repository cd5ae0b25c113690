// cohsm_lookup - reads one stored depth of a csm block (docs/csm-format.md), whose words a texture holds.
//
// COHSM_TEXEL(i) is the including program's uvec4 of words 4 i .. 4 i + 3, where i, a uint, counts through
// all blocks that were uploaded. cohsm_open reads what queries need of a block's header: keep its result.
// COHSM_ONE_DOMAIN, COHSM_ONE_ORDER and COHSM_ONE_ORIENTATION may be defined as the number that all blocks
// have there, COHSM_ONE_LAYOUT as 1 if all came from cohsm_data and as 2 if all came from cohsm_fast_data;
// the code for others is gone then.
#ifndef COHSM_TEXEL
#error "cohsm_lookup: COHSM_TEXEL(i), texel i of the blocks"
#endif

// What a program knows as a constant is compared as one, so that compilers drop the other code at once,
// before they put all calls in line: code that is only found dead later takes most of the time.
#ifdef COHSM_ONE_DOMAIN
#define COHSM_DOMAIN_OF(m) uint(COHSM_ONE_DOMAIN)
#else
#define COHSM_DOMAIN_OF(m) m.domain
#endif
#if defined(COHSM_ONE_DOMAIN) && COHSM_ONE_DOMAIN < 8
#define COHSM_POSITIONAL(m) (COHSM_ONE_DOMAIN > 2)
#else
#define COHSM_POSITIONAL(m) m.positional
#endif
#ifdef COHSM_ONE_ORDER
#define COHSM_ORDER_OF(m) uint(COHSM_ONE_ORDER)
#else
#define COHSM_ORDER_OF(m) m.order
#endif
#ifdef COHSM_ONE_ORIENTATION
#define COHSM_ORIENTATION_OF(m) uint(COHSM_ONE_ORIENTATION)
#else
#define COHSM_ORIENTATION_OF(m) m.orientation
#endif
#ifdef COHSM_ONE_LAYOUT
#define COHSM_FAST(m) (COHSM_ONE_LAYOUT > 1)
#else
#define COHSM_FAST(m) m.fast
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
#define COHSM_ORIENTATION_POLAR 1u
#define COHSM_ORIENTATION_MINIMAL 2u

struct cohsm_maps {
    uint  base;                     // texel of the first word
    uint  domain;                   // COHSM_DOMAIN_...
    uint  order;                    // COHSM_ORDER_..., or by cells
    uint  orientation;              // COHSM_ORIENTATION_..., or two poles
    uvec3 side;                     // cells along each dimension
    uint  map_count;
    uint  map_size;                 // pixels a side of a map
    uint  depth_top;                // greatest value of the grid of depths
    uint  depth_step;               // 65,536 times the depth between two values of the grid, rounded up
    uint  dimensions;
    bool  positional;               // maps of positions, with six faces
    bool  self_only;                // pixels that nothing hits may shadow anything
    uint  pixel_begin;              // the block has pixels pixel_begin .. pixel_end - 1
    uint  pixel_end;
    uint  order_at;                 // sections, in words from the first one
    uint  locations_at;
    uint  lookup_at;
    uint  directories_at;
    uint  lines_at;
    bool  fast;                     // the block has trays in place of lists
    uint  bases_at;                 // sections of trays; their lines are at lines_at, too
    uint  trays_at;
    vec3  center;                   // of the object's sphere
    float radius,
          depth_far;                // maps of positions: the depth that is stored as the greatest
};

// Returns what texels 1 to 7 of the block at texel `base` say.
cohsm_maps cohsm_unpack(uint base, uvec4 kinds, uvec4 sides, uvec4 sizes, uvec4 range, uvec4 lengths,
                        uvec4 rest, uvec4 sphere)
{
    cohsm_maps m;
    m.base = base;
    m.domain = kinds.x;
    m.order = kinds.z;
    m.orientation = kinds.w;
    m.side = sides.xyz;
    m.map_count = sides.w;
    m.map_size = sizes.y;
    m.depth_top = (1u << sizes.z) - 1u;
    m.depth_step = 65535u * 65536u / m.depth_top + 1u;
    m.dimensions = sizes.w;
    m.positional = range.x != 0u;
    m.self_only = (range.y & 1u) != 0u;
    m.pixel_begin = range.z;
    m.pixel_end = range.w;
    m.order_at = 96u;
    m.locations_at = m.order_at + lengths.x;
    m.lookup_at = m.locations_at + lengths.y;
    m.directories_at = m.lookup_at + lengths.z;
    m.fast = (range.y & 2u) != 0u;
#ifdef COHSM_ONE_LAYOUT
    m.fast = COHSM_ONE_LAYOUT > 1;
#endif
    m.lines_at = cohsm_if(m.fast, (m.lookup_at + 15u) & ~15u, m.directories_at + lengths.w);
    m.bases_at = m.lines_at + lengths.z;
    m.trays_at = m.bases_at + lengths.w;
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
#ifdef COHSM_ONE_ORIENTATION
    m.orientation = uint(COHSM_ONE_ORIENTATION);
#endif
    return m;
}

// Reads the header of the block at texel `base`.
cohsm_maps cohsm_open(uint base)
{
    return cohsm_unpack(base, COHSM_TEXEL(base + 1u), COHSM_TEXEL(base + 2u), COHSM_TEXEL(base + 3u),
                        COHSM_TEXEL(base + 4u), COHSM_TEXEL(base + 5u), COHSM_TEXEL(base + 6u),
                        COHSM_TEXEL(base + 7u));
}

// Returns component i modulo 4.
uint cohsm_pick(uvec4 t, uint i)
{
    return cohsm_if((i & 2u) != 0u, cohsm_if((i & 1u) != 0u, t.w, t.z), cohsm_if((i & 1u) != 0u, t.y, t.x));
}

// Returns word i of a block.
uint cohsm_word(const in cohsm_maps m, uint i) { return cohsm_pick(COHSM_TEXEL(m.base + (i >> 2)), i); }

// Returns the floats that words i .. i + 2 hold.
vec3 cohsm_floats(const in cohsm_maps m, uint i)
{
    return uintBitsToFloat(uvec3(cohsm_word(m, i), cohsm_word(m, i + 1u), cohsm_word(m, i + 2u)));
}

// Returns how many bits of x are 1.
uint cohsm_popcount(uint x)
{
#if __VERSION__ >= 400 || (defined(GL_ES) && __VERSION__ >= 310)
    return uint(bitCount(x));
#endif
    x -= (x >> 1) & 0x55555555u;
    x = (x & 0x33333333u) + ((x >> 2) & 0x33333333u);
    x = (x + (x >> 4)) & 0x0f0f0f0fu;
    return (x * 0x01010101u) >> 24;
}

// Returns the position of the one with this number, from 0, in x, which has more ones. It halves x by the
// counts of ever smaller parts.
uint cohsm_select(uint x, uint number)
{
    uint two = x - ((x >> 1) & 0x55555555u);
    uint four = (two & 0x33333333u) + ((two >> 2) & 0x33333333u);
    uint eight = (four + (four >> 4)) & 0x0f0f0f0fu, at = 0u, n = (eight + (eight >> 8)) & 0xffu;
    if (number >= n) { number -= n; at = 16u; }
    n = (eight >> at) & 15u;
    if (number >= n) { number -= n; at += 8u; }
    n = (four >> at) & 7u;
    if (number >= n) { number -= n; at += 4u; }
    n = (two >> at) & 3u;
    if (number >= n) { number -= n; at += 2u; }
    n = (x >> at) & 1u;
    return cohsm_if(number >= n, at + 1u, at);
}

// Returns the marks of a block of segments: ones are segments, zeros ends of buckets.
uvec2 cohsm_marks(uint w0, uint w1, uint w2)
{
    return uvec2((w0 >> 16) | (w1 << 16), (w1 >> 16) | (w2 << 16));
}

// Returns the position after the zero with this number.
uint cohsm_after_zero(uvec2 marks, uint number)
{
    uvec2 zeros = ~marks;
    uint low = cohsm_popcount(zeros.x);
    bool second = number >= low;
    uint at = cohsm_select(cohsm_if(second, zeros.y, zeros.x), cohsm_if(second, number - low, number));
    return at + cohsm_if(second, 33u, 1u);
}

// Returns the 16-bit depth of a value of the grid; the last one and those above are infinite. The product is
// g * 65535 / depth_top, rounded down: depth_step is at most 1 too large, and 254 / 65536 is less than what
// such a quotient lacks to the next whole number, 1 / 127 or more.
uint cohsm_grid_depth(const in cohsm_maps m, uint g)
{
    return cohsm_if(g >= m.depth_top, 65535u, (g * m.depth_step) >> 16);
}

// ---- lines: the 64 bytes that a block of segments lies in, fetched at once ----

struct cohsm_line {
    uvec4 a, b, c, d;               // its 16 words
    uint  bit;                      // where the block of segments begins in it
};

// Fetches the line of a word, with which a block of segments begins.
cohsm_line cohsm_fetch_line(const in cohsm_maps m, uint word)
{
    uint i = m.base + (word >> 4 << 2);
    return cohsm_line(COHSM_TEXEL(i), COHSM_TEXEL(i + 1u), COHSM_TEXEL(i + 2u), COHSM_TEXEL(i + 3u),
                      (word & 15u) << 5);
}

// Returns word i of a line.
uint cohsm_line_word(const in cohsm_line l, uint i)
{
    bool odd = (i & 4u) != 0u;
    return cohsm_pick(cohsm_if((i & 8u) != 0u, cohsm_if(odd, l.d, l.c), cohsm_if(odd, l.b, l.a)), i);
}

// Returns `count` bits, 0..32, of the block of segments from one of its bits on.
uint cohsm_bits(const in cohsm_line l, uint bit, uint count)
{
    bit += l.bit;
    uint at = bit >> 5, shift = bit & 31u, x = cohsm_line_word(l, at) >> shift;
    if (shift + count > 32u) x |= cohsm_line_word(l, at + 1u) << (32u - shift);
    return cohsm_if(count > 0u, x & (0xffffffffu >> (32u - count)), 0u);
}

// Returns which segment of a block holds a view, counted from the block's first.
uint cohsm_segment(const in cohsm_line l, uint head, uvec2 marks, uint view)
{
    uint k = (head >> 8) & 15u, bucket = view >> k, low = view & ((1u << k) - 1u);
    uint at = bucket > 0u ? cohsm_after_zero(marks, bucket - 1u) : 0u, j = at - bucket;
    while (at < 64u && ((cohsm_if(at < 32u, marks.x, marks.y) >> (at & 31u)) & 1u) != 0u &&
           cohsm_bits(l, 80u + j * k, k) <= low) {
        at++;
        j++;
    }
    return j - 1u;
}

// Returns how many of the first `count` codes have all bits set. As many as fit into a word are compared at
// once: a one that is added to a code without its highest bit carries into that bit if all others are set.
uint cohsm_escapes(const in cohsm_line l, uint codes, uint bits, uint count)
{
    uint step = 32u / bits, one = (0xffffffffu >> (32u - step * bits)) / ((1u << bits) - 1u);
    uint high = one << (bits - 1u), rank = 0u;
    for (uint i = 0u; i < count; i += step) {
        uint x = cohsm_bits(l, codes + i * bits, min(step, count - i) * bits);
        rank += cohsm_popcount(((x & ~high) + one) & x & high);
    }
    return rank;
}

// Returns the 16-bit depth of segment j of a block.
uint cohsm_segment_depth(const in cohsm_maps m, const in cohsm_line l, uint head, uvec2 marks, uint j)
{
    uint n = cohsm_popcount(marks.x) + cohsm_popcount(marks.y);
    uint k = (head >> 8) & 15u, bits = (head >> 12) & 15u, base = head & 255u, codes = 80u + n * k;
    bool palette = bits > 9u;
    if (palette) bits -= 9u;
    uint code = cohsm_bits(l, codes + j * bits, bits), ones = (1u << bits) - 1u;
    uint values = codes + n * bits, rank = 0u, depth = base + code;
    bool exact = code == ones, infinite = code + 1u == ones && !palette;
    if (exact) rank = cohsm_escapes(l, codes, max(bits, 1u), min(j, 64u));
    values += cohsm_if(exact, cohsm_if(palette, 8u * base, 0u) + 16u * rank, 8u * code);
    if (exact || palette) depth = cohsm_bits(l, values, cohsm_if(exact, 16u, 8u));
    uint grid = cohsm_grid_depth(m, depth);
    grid = infinite ? 65535u : grid;
    return exact ? depth : grid;
}

// Returns which block of a list holds a view, and the first view of that block.
uvec2 cohsm_find_block(const in cohsm_maps m, uint list, uint count, uint view)
{
    uint from = 2u * list + 4u;                     // a texel has eight first views
    uint low = from >> 3, high = (from + count + 6u) >> 3;
    uvec2 found = uvec2(0u);
    while (low < high) {
        uint middle = (low + high) >> 1, i = 8u * middle - from;
        uvec4 t = COHSM_TEXEL(m.base + middle), even = t & 0xffffu, odd = t >> 16;
        uvec4 number = i + uvec4(0u, 2u, 4u, 6u), top = uvec4(count - 1u), asked = uvec4(view);
        even = (even + 1u) * uvec4(lessThan(number, top)) * uvec4(lessThanEqual(even, asked));
        odd = (odd + 1u) * uvec4(lessThan(number + 1u, top)) * uvec4(lessThanEqual(odd, asked));
        uvec4 last = max(even, odd), ones = min(even, 1u) + min(odd, 1u);
        uint first = max(max(last.x, last.y), max(last.z, last.w));     // 1 more, or 0: none begins before
        if (first > 0u) {
            found = uvec2((8u * middle < from ? 0u : i) + ones.x + ones.y + ones.z + ones.w, first - 1u);
            low = middle + 1u;
        } else
            high = middle;
    }
    return found;
}

// Returns the 16-bit depth that a list of blocks, which begins at a word, holds for a view.
uint cohsm_list_depth(const in cohsm_maps m, uint list, uint view)
{
    uvec4 t = COHSM_TEXEL(m.base + (list >> 2));
    uint first = cohsm_pick(t, list), count = cohsm_pick(t, list + 1u);
    if ((list & 3u) == 3u) count = COHSM_TEXEL(m.base + (list >> 2) + 1u).x;
    uint tail = count >> 16;
    count &= 0xffffu;
    uvec2 block = cohsm_find_block(m, list, count, view);
    uint line = cohsm_if(block.x + 1u < count, 16u * (first + block.x),
                         16u * (first - (tail >> 4)) + (tail & 15u));
    cohsm_line l = cohsm_fetch_line(m, m.lines_at + line);
    uint at = l.bit >> 5, head = cohsm_line_word(l, at);
    uvec2 marks = cohsm_marks(head, cohsm_line_word(l, at + 1u), cohsm_line_word(l, at + 2u));
    return cohsm_segment_depth(m, l, head, marks, cohsm_segment(l, head, marks, view - block.y));
}

// ---- trays: the fast layout, of blocks that came from cohsm_fast_data ----

// Returns byte i modulo 16.
uint cohsm_byte(uvec4 t, uint i) { return (cohsm_pick(t, i >> 2) >> ((i & 3u) << 3)) & 255u; }

// Returns half word i of a run that begins at a word.
uint cohsm_half_word(const in cohsm_maps m, uint word, uint i)
{
    return (cohsm_word(m, word + (i >> 1)) >> ((i & 1u) << 4)) & 0xffffu;
}

// Returns the highest bits of the bytes of two texels as one word: bit 8 b + w is that of byte b of word w.
uint cohsm_high_bits(uvec4 s, uvec4 t)
{
    s &= 0x80808080u;
    t &= 0x80808080u;
    return (s.x >> 7) | (s.y >> 6) | (s.z >> 5) | (s.w >> 4) | (t.x >> 3) | (t.y >> 2) | (t.z >> 1) | t.w;
}

// Returns, in the order of cohsm_high_bits, which bytes are at most v. The lower seven bits are compared by a
// subtraction in which no byte borrows from the next one, the highest bits by logic.
uint cohsm_bytes_up_to(uvec4 s, uvec4 t, uint v)
{
    uvec4 all = uvec4(v * 0x01010101u), least = all | 0x80808080u;
    uvec4 x = least - (s & 0x7f7f7f7fu), y = least - (t & 0x7f7f7f7fu);
    return cohsm_high_bits((all & ~s) | (~(all ^ s) & x), (all & ~t) | (~(all ^ t) & y));
}

// Returns, in the order of cohsm_high_bits, which bytes are 254: those whose difference from it has no bit.
uint cohsm_bytes_exact(uvec4 s, uvec4 t)
{
    s ^= 0xfefefefeu;
    t ^= 0xfefefefeu;
    uvec4 x = (s & 0x7f7f7f7fu) + 0x7f7f7f7fu, y = (t & 0x7f7f7f7fu) + 0x7f7f7f7fu;
    return cohsm_high_bits(~(x | s), ~(y | t));
}

// Returns the bits that stand for the first bytes of two texels, of no more than 32.
uint cohsm_bytes_before(uint count)
{
    count = min(count, 32u);
    uint more = 0x01010101u & ((1u << ((count & 3u) << 3)) - 1u);
    return ((0x01010101u + more) << (count >> 2)) - 0x01010101u;
}

// Returns the texel in which the tray of a pixel and view begins, and the byte of that texel. Of a split tray
// that is the line for the view.
uvec2 cohsm_tray_at(const in cohsm_maps m, uint pixel, uint place)
{
    uint pixels = m.pixel_end - m.pixel_begin, bucket = place >> 8;
    uint tray = cohsm_half_word(m, m.trays_at, bucket * pixels + pixel), first = tray & 0x3fffu;
    uint line = cohsm_word(m, m.bases_at + bucket * ((pixels + 255u) >> 8) + (pixel >> 8));
    uint split = tray >> 14, part = (place & 255u) >> (8u - split);
    uint byte = cohsm_if(split > 0u, (first + part) << 6, first << 1);
    return uvec2(m.base + (m.lines_at >> 2) + (line << 2) + (byte >> 4), byte & 15u);
}

// Returns the depth of a view whose code, at a byte of the line of its tray, says that the depth stands
// elsewhere: after the codes, which begin at byte `codes`, after as many others as such codes stand before
// this one; or, where a tray has 31 first views, view by view some lines further on. a and b are the texels
// `texel` and the next one, from which bytes count.
uint cohsm_tray_exact(uint texel, uvec4 a, uvec4 b, uint count, uint codes, uint byte, uint view)
{
    uvec4 c = COHSM_TEXEL(texel + 2u), d = COHSM_TEXEL(texel + 3u);
    uint low = cohsm_bytes_exact(a, b) & (cohsm_bytes_before(byte) ^ cohsm_bytes_before(codes));
    uint high = cohsm_bytes_exact(c, d);
    high &= cohsm_bytes_before(max(byte, 32u) - 32u) ^ cohsm_bytes_before(max(codes, 32u) - 32u);
    uint at = codes + count + 1u + 2u * (cohsm_popcount(low) + cohsm_popcount(high));
    at = cohsm_if(count == 31u, 64u * cohsm_byte(a, 1u) + 2u * (view & 31u), at);
    return (cohsm_pick(COHSM_TEXEL(texel + (at >> 4)), at >> 2) >> ((at & 2u) << 3)) & 0xffffu;
}

// Returns the 16-bit depth that the tray of a pixel holds for a view. The first views of its segments rise:
// as many of them as are not above the view, counted at once, come before its code. Two texels hold them all
// but in one of a few hundred questions.
uint cohsm_tray_depth(const in cohsm_maps m, uint pixel, uint place)
{
    uvec2 tray = cohsm_tray_at(m, pixel, place);
    uvec4 a = COHSM_TEXEL(tray.x), b = COHSM_TEXEL(tray.x + 1u);
    uint view = place & 255u, count = cohsm_byte(a, tray.y), firsts = tray.y + 1u, codes = firsts + count;
    uint up_to = cohsm_bytes_up_to(a, b, view) & (cohsm_bytes_before(codes) ^ cohsm_bytes_before(firsts));
    uint byte = codes + cohsm_popcount(up_to);
    if (codes > 32u) {
        uvec4 c = COHSM_TEXEL(tray.x + 2u);
        byte += cohsm_popcount(cohsm_bytes_up_to(c, c, view) & cohsm_bytes_before(codes - 32u));
    }
    uint code = cohsm_byte(COHSM_TEXEL(tray.x + (byte >> 4)), byte), depth = cohsm_grid_depth(m, code);
    if (code == 254u) depth = cohsm_tray_exact(tray.x, a, b, count, codes, byte, view);
    return depth;
}

// ---- either layout ----

// Returns the 16-bit depth that the list of a pixel holds for a view.
uint cohsm_listed_depth(const in cohsm_maps m, uint pixel, uint place)
{
    uint entry = cohsm_word(m, m.lookup_at + (place >> 16) * (m.pixel_end - m.pixel_begin) + pixel);
    uint depth = entry & 0xffffu;
    if ((entry & 0x80000000u) == 0u) depth = cohsm_list_depth(m, m.directories_at + entry, place & 0xffffu);
    return depth;
}

// Returns the stored 16-bit depth of a pixel, counted from pixel_begin, in the view with this place in the
// sequence. Its C twin is cohsm__stored_depth, public as cohsm_depths.
uint cohsm_stored_depth(const in cohsm_maps m, uint pixel, uint place)
{
    uint depth = 0u;
    if (COHSM_FAST(m)) depth = cohsm_tray_depth(m, pixel, place);
    if (!COHSM_FAST(m)) depth = cohsm_listed_depth(m, pixel, place);
    return depth;
}

// Returns the stored depths of four pixels in one view. Trays are read side by side, so that their fetches
// overlap; lists, which take loops, one after the other.
uvec4 cohsm_stored_depths(const in cohsm_maps m, uvec4 pixels, uint place)
{
    uvec4 depths = uvec4(0u);
    if (COHSM_FAST(m))
        depths = uvec4(cohsm_tray_depth(m, pixels.x, place), cohsm_tray_depth(m, pixels.y, place),
                       cohsm_tray_depth(m, pixels.z, place), cohsm_tray_depth(m, pixels.w, place));
    if (!COHSM_FAST(m))
        for (int i = 0; i < 4; i++) {
            depths = uvec4(depths.yzw, cohsm_listed_depth(m, pixels.x, place));
            pixels = pixels.yzwx;
        }
    return depths;
}
