/* ---- lists: the format ---- */

/* One pixel's depths over the views of a chunk are piecewise constant: segments, each with a first view and a
   depth. A list is cut into blocks of one cache line each; the last one, its tail, is as short as it can be
   and shares a line with the tails of other lists. A directory says where they are. Its first word is the
   number of the first block's line; its second word holds the count of blocks (low 16 bits), the word in its
   line at which the tail begins (4 bits), and how many lines before the first block's line the tail's line is
   (12 bits); 16 bits follow for the first view of every block but the first. A query so reads lookup and
   directory, which are small and stay in a near cache, and one line of the large rest.

   A block, read as a string of bits from the low end of its first word, is

     8 base, 4 k, 4 width     k and width are the lengths of the low bits and codes below
     64 marks                 Elias-Fano: the block's views fall into buckets of 2^k; for each bucket a 1 for
                              every segment that begins in it, then a 0. The first segment begins at the
                              block's first view
     n x k low bits           the first view of each segment within its bucket
     n x width codes          width 1..9: the depth on the grid, less base; all ones but the last bit mean
                              infinite. width 10..15: a code has width - 9 bits and is a place in a palette of
                              `base` depths. All ones mean exact, in both
     base x 8 bits            the palette, if there is one
     16 bits each             the exact depths, in order

   n is the number of segments. A search finds its bucket by counting zeros, and then compares a few low bits:
   its time is the same whatever the number of segments. */

enum { COHSM__BLOCK_BITS = 32 * COHSM__BLOCK_WORDS, COHSM__MARKS = 64, COHSM__LOW_AT = 16 + COHSM__MARKS,
       COHSM__WIDEST = 9, COHSM__FARTHEST_TAIL = 4095 };

typedef struct cohsm__segment {
    uint16_t first;                     /* view within the chunk */
    uint16_t lo, hi;                    /* grid values that separate the layers; if exact, lo is the depth and
                                           hi unused */
    uint16_t exact;
} cohsm__segment;

/* Reads a field of up to 30 bits of a block, which lies 32 bits or more from the block's begin. The
   function reads the word before the field's last word and never the word after, which may lie in another
   cache line: such a miss would cost more than the whole search. */
static uint32_t cohsm__bits(const uint32_t *block, uint32_t bit, uint32_t count)
{
    uint32_t i = ((bit + count - 1u) >> 5) - 1u;
    const uint32_t *w = block + i;
    return (uint32_t)((w[0] | (uint64_t)w[1] << 32) >> (bit - 32u * i)) & ((1u << count) - 1u);
}

static void cohsm__put_bits(uint32_t *words, uint32_t bit, uint32_t count, uint32_t value)
{
    uint32_t *w = words + (bit >> 5);
    uint64_t shifted = (uint64_t)value << (bit & 31u);
    w[0] |= (uint32_t)(shifted & 0xffffffffu);
    if ((bit & 31u) + count > 32) w[1] |= (uint32_t)(shifted >> 32);
}

static uint32_t cohsm__half_word(const uint32_t *words, uint32_t i)
{
    return words[i >> 1] >> (16 * (i & 1u)) & 0xffffu;
}

static uint64_t cohsm__marks(const uint32_t *block)
{
    return (block[0] | (uint64_t)block[1] << 32) >> 16 | (uint64_t)block[2] << 48;
}

/* Where the fields of a block begin. */
typedef struct cohsm__fields { uint32_t n, k, bits, palette, codes_at, palette_at, exact_at; } cohsm__fields;

static cohsm__fields cohsm__block_fields(const uint32_t *block, uint32_t n)
{
    cohsm__fields f;
    f.n = n;
    f.k = block[0] >> 8 & 15u;
    f.bits = block[0] >> 12 & 15u;
    f.palette = f.bits > COHSM__WIDEST ? block[0] & 255u : 0u;
    if (f.bits > COHSM__WIDEST) f.bits -= COHSM__WIDEST;
    f.codes_at = COHSM__LOW_AT + n * f.k;
    f.palette_at = f.codes_at + n * f.bits;
    f.exact_at = f.palette_at + 8u * f.palette;
    return f;
}

/* Returns the 16-bit depth of segment j in a block of n. An exact depth has as many exact depths before it as
   there are codes of all ones before j. */
COHSM__INLINE uint32_t cohsm__block_depth(const uint32_t *block, const uint16_t *depth_of, uint32_t n,
                                          uint32_t j)
{
    uint32_t head = block[0], bits = head >> 12 & 15u;
    uint32_t palette = 0u - (uint32_t)(bits > COHSM__WIDEST), ones, codes_at;
    uint32_t code, value, i, rank = 0;

    bits -= (uint32_t)COHSM__WIDEST & palette;
    ones = (1u << bits) - 1u;
    codes_at = COHSM__LOW_AT + n * (head >> 8 & 15u);
    code = cohsm__bits(block, codes_at + j * bits, bits);
    if (code == ones) {
        for (i = 0; i < j; i++) rank += cohsm__bits(block, codes_at + i * bits, bits) == ones;
        return cohsm__bits(block, cohsm__block_fields(block, n).exact_at + 16 * rank, 16);
    }
    /* This place of the table means infinite, as all places from the grid's top on do. */
    value = code + 1u == ones ? 511u : (head & 255u) + code;
    code = cohsm__bits(block, codes_at + ((n * bits + 8u * code) & palette), 8);
    return depth_of[(code & palette) | (value & ~palette)];
}

/* Returns the segment of a block that holds a view. offset is the view less the block's first; at is where
   the view's bucket begins in the marks. The data decides no branches but for rare cases: a mispredicted
   branch costs as much as ten instructions. */
static inline uint32_t cohsm__segment_at(const uint32_t *block, uint64_t marks, uint32_t offset, uint32_t at)
{
    uint32_t k = block[0] >> 8 & 15u, j = at - (offset >> k), mask = (1u << k) - 1u, low = offset & mask;
    uint32_t run, more, lows;

    run = (uint32_t)((marks >> (at & 63u)) & (at < 64 ? 7u : 0u));
    /* This reads the low bits of two segments, or of one and what follows, which are codes and never too
       short. */
    lows = cohsm__bits(block, COHSM__LOW_AT + j * k, 2u * k);
    more = run & (uint32_t)((lows & mask) <= low);
    j += more & 1u;
    more &= run >> 1 & (uint32_t)(lows >> k <= low);
    j += more & 1u;
    if (more & run >> 2 & 1u)
        for (at += 2; at < 64 && (marks >> at & 1u) && cohsm__bits(block, COHSM__LOW_AT + j * k, k) <= low;
             at++)
            j++;
    return j - 1u;
}

static uint32_t cohsm__block_find(const uint32_t *block, uint32_t offset)
{
    uint64_t marks = cohsm__marks(block);
    uint32_t bucket = offset >> (block[0] >> 8 & 15u);
    return cohsm__segment_at(block, marks, offset, bucket ? cohsm__select_bit(~marks, bucket - 1u) + 1u : 0u);
}

/* Returns how many words a block takes, by its exact codes. */
static uint32_t cohsm__block_words(const uint32_t *block)
{
    cohsm__fields f = cohsm__block_fields(block, cohsm__popcount(cohsm__marks(block)));
    uint32_t j, size = f.exact_at, ones = (1u << f.bits) - 1u;
    for (j = 0; j < f.n; j++) size += cohsm__bits(block, f.codes_at + j * f.bits, f.bits) == ones ? 16u : 0u;
    return (size + 31u) / 32u;
}

static uint32_t cohsm__block_count(const uint32_t *directory) { return directory[1] & 0xffffu; }
static uint32_t cohsm__block_first(const uint32_t *directory, uint32_t b)
{
    return cohsm__half_word(directory, b + 3u);
}

static const uint32_t *cohsm__block_at(const uint32_t *directory, const uint32_t *lines, uint32_t b)
{
    uint32_t tail = directory[1] >> 16;
    if (b + 1u < cohsm__block_count(directory))
        return lines + COHSM__BLOCK_WORDS * ((size_t)directory[0] + b);
    return lines + COHSM__BLOCK_WORDS * ((size_t)directory[0] - (tail >> 4)) + (tail & 15u);
}

/* Returns the last block of a list that begins at or before the view, and counts the view from there. */
static const uint32_t *cohsm__list_block(const cohsm_maps *m, const uint32_t *directory, uint32_t *view)
{
    uint32_t lo = 0, count = cohsm__block_count(directory), half;
    for (; count > 1; count -= half) {              /* halving without branches */
        half = count / 2;
        lo += half & (0u - (uint32_t)(cohsm__block_first(directory, lo + half) <= *view));
    }
    if (lo) *view -= cohsm__block_first(directory, lo);
    return cohsm__block_at(directory, m->lines, lo);
}

static uint32_t cohsm__depth_in_block(const cohsm_maps *m, const uint32_t *block, uint32_t view)
{
    return cohsm__block_depth(block, m->depth_of, cohsm__popcount(cohsm__marks(block)),
                              cohsm__block_find(block, view));
}

static uint32_t cohsm__stored_depth(const cohsm_maps *m, uint32_t pixel, uint32_t place)
{
    const uint32_t *block;
    uint32_t entry;
#ifndef COHSM_WITHOUT_FAST
    if (m->trays.lines) return cohsm__tray_depth(m, cohsm__tray_at(m, pixel, place), place);
#endif
    entry = m->lookup[(size_t)(place >> COHSM__CHUNK_BITS) * m->range + pixel];
    if (entry & COHSM__CONSTANT) return entry & 0xffffu;
    place &= COHSM__CHUNK - 1u;
    block = cohsm__list_block(m, m->directories + entry, &place);
    return cohsm__depth_in_block(m, block, place);
}
