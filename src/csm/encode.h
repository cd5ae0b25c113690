/* ---- encode: segments to lists ---- */

/* The grid of stored depths: values 0..top, of which top means infinite. A stored value lies at most `margin`
   behind the first hit. */
typedef struct cohsm__grid { uint32_t top, margin; } cohsm__grid;

/* Returns the grid value that is stored for an interval lo..hi. The middle leaves the most room on both sides
   (paper 3.1). But a value far behind the first hit lets light through to whatever is there, other objects
   among them, so the value stays within two pixels of the first hit. */
static uint32_t cohsm__choose_value(const cohsm__grid *g, uint32_t lo, uint32_t hi)
{
    uint32_t middle = (lo + hi) / 2u;
    return middle < lo + g->margin ? middle : lo + g->margin;
}

static cohsm__grid cohsm__grid_of(uint32_t depth_bits, uint32_t map_side)
{
    cohsm__grid g;
    g.top = (1u << depth_bits) - 1u;
    g.margin = (2u * g.top + map_side - 1u) / map_side;
    return g;
}

/* A block of the first n segments: how they would be coded, and how many bits that would take. */
typedef struct cohsm__plan {
    uint32_t n, exact;                  /* segments taken so far; those of them with exact depths */
    uint32_t least_hi, greatest_lo;     /* of the intervals of these segments */
    uint32_t k, bits, base;             /* the block's fields, see "lists" */
    uint32_t values, size;              /* grid values that the codes span; bits that the block takes */
    uint32_t palette;                   /* entries of the palette; 0: there is none */
} cohsm__plan;

static void cohsm__plan_start(cohsm__plan *p)
{
    memset(p, 0, sizeof *p);
    p->least_hi = COHSM__INFINITE;
}

/* Returns the greatest grid value of a segment's interval; only what is infinite has the infinite one. */
static uint32_t cohsm__last_value(const cohsm__segment *s, const cohsm__grid *grid)
{
    return s->lo >= grid->top ? grid->top : cohsm__min_u32(s->hi, grid->top - 1u);
}

/* Returns how many values cohsm__pierce finds. It takes the last values of the intervals in ascending order,
   and of intervals that share one, the latest beginning: one that begins behind the value found last needs a
   new value. A block asks this for each segment that it tries to take. */
static uint32_t cohsm__count_values(const cohsm__segment *s, uint32_t n, const cohsm__grid *grid)
{
    uint64_t present[4], bit, left;         /* a bit for each grid value that is the last of an interval */
    uint8_t begin[256];                     /* of those: where the latest of these intervals begins */
    uint32_t i, last, count = 0, at = 0;

    memset(present, 0, sizeof present);
    for (i = 0; i < n; i++) {
        if (s[i].exact) continue;
        last = cohsm__last_value(s + i, grid);
        bit = (uint64_t)1 << (last & 63u);
        if (!(present[last >> 6] & bit) || begin[last] < s[i].lo) begin[last] = (uint8_t)s[i].lo;
        present[last >> 6] |= bit;
    }
    for (i = 0; i < 4; i++)
        for (left = present[i]; left; left &= left - 1u) {
            last = 64u * i + cohsm__popcount(~left & (left - 1u));
            if (count && begin[last] <= at) continue;
            at = last;
            count++;
        }
    return count;
}

/* Finds the fewest grid values with one in each interval: the least hi that is left must be met, and a value
   as large as that meets the most others. Each value then moves to the middle of what its intervals have in
   common. Writes the values, and for each segment the number of its value. */
static void cohsm__pierce(const cohsm__segment *s, uint32_t n, const cohsm__grid *grid, uint8_t *value,
                          uint8_t *code)
{
    uint8_t todo[COHSM__MARKS];
    uint32_t i, count = 0, left = 0;
    uint32_t at, lo;

    for (i = 0; i < n; i++)
        if (!s[i].exact) todo[left++] = (uint8_t)i;
    for (; left; count++) {
        for (i = 0, at = grid->top; i < left; i++)
            at = cohsm__min_u32(at, cohsm__last_value(&s[todo[i]], grid));
        for (i = 0, lo = 0, n = left, left = 0; i < n; i++) {
            if (s[todo[i]].lo <= at) {
                lo = cohsm__max_u32(lo, s[todo[i]].lo);
                code[todo[i]] = (uint8_t)count;
            } else todo[left++] = todo[i];
        }
        value[count] = (uint8_t)cohsm__choose_value(grid, lo, at);
    }
}

/* Computes the bits of a block. Returns 0 if there are too many. */
static int cohsm__plan_size(cohsm__plan *p)
{
    p->size = COHSM__LOW_AT + p->n * (p->k + p->bits) + 8u * p->palette + 16u * p->exact;
    return p->size <= COHSM__BLOCK_BITS;
}

/* Plans the block with a palette. Returns 0 if it does not fit so. */
static int cohsm__plan_palette(cohsm__plan *p, const cohsm__segment *s, const cohsm__grid *grid)
{
    p->palette = cohsm__count_values(s, p->n, grid);
    for (p->bits = 1; (1u << p->bits) - 1u < p->palette; p->bits++) {}
    return p->palette && p->bits <= 15 - COHSM__WIDEST && cohsm__plan_size(p);
}

/* Takes one more segment into a plan; returns 0 if the block would become too long. end is the first view
   after the segment. */
static int cohsm__plan_take(cohsm__plan *p, const cohsm__segment *s, const cohsm__grid *grid, uint32_t end)
{
    uint32_t span = end - s[0].first;
    const cohsm__segment *last = s + p->n;

    if (p->n == COHSM__MARKS) return 0;
    p->n++;
    if (last->exact) p->exact++;
    else if (last->lo < grid->top) {
        p->least_hi = cohsm__min_u32(p->least_hi, cohsm__min_u32(last->hi, grid->top - 1u));
        p->greatest_lo = cohsm__max_u32(p->greatest_lo, last->lo);
    }
    for (p->k = 0; p->n + ((span - 1u) >> p->k) > COHSM__MARKS; p->k++)
        if (p->k == 15) return 0;
    /* This is the narrowest range of grid values with one in each interval: from the least hi to the greatest
       lo. */
    p->base = cohsm__min_u32(p->least_hi, p->greatest_lo);
    p->values = p->least_hi < p->greatest_lo ? p->greatest_lo - p->least_hi + 1u : 1u;
    if (p->least_hi == COHSM__INFINITE) p->base = 0;
    else if (p->least_hi > p->greatest_lo) p->base = cohsm__choose_value(grid, p->greatest_lo, p->least_hi);
    p->palette = 0;
    for (p->bits = 1; (1u << p->bits) - 2u < p->values; p->bits++) {}
    return cohsm__plan_size(p) || cohsm__plan_palette(p, s, grid);
}

static uint32_t cohsm__segment_end(const cohsm__segment *s, size_t i, size_t count, uint32_t views)
{
    return i + 1 < count ? s[i + 1].first : views;
}

/* Plans a block of as many segments as fit; for a tail by whichever coding is shorter. */
static cohsm__plan cohsm__plan_block(const cohsm__segment *s, size_t count, const cohsm__grid *grid,
                                     uint32_t views)
{
    cohsm__plan best, next;
    cohsm__plan_start(&next);
    best = next;
    while (next.n < count && cohsm__plan_take(&next, s, grid, cohsm__segment_end(s, next.n, count, views)))
        best = next;
    next = best;
    if (best.n == count && !best.palette && cohsm__plan_palette(&next, s, grid) && next.size < best.size)
        best = next;
    return best;
}

static uint32_t cohsm__range_code(const cohsm__segment *s, const cohsm__plan *p, const cohsm__grid *grid)
{
    uint32_t value = cohsm__choose_value(grid, s->lo, cohsm__min_u32(s->hi, grid->top - 1u));
    if (s->lo >= grid->top) return (1u << p->bits) - 2u;
    return cohsm__max_u32(p->base, cohsm__min_u32(value, p->base + p->values - 1u)) - p->base;
}

static void cohsm__write_block(uint32_t *block, const cohsm__segment *s, cohsm__plan *p,
                               const cohsm__grid *grid)
{
    uint32_t i, offset, code;
    uint32_t bucket = 0, at = 16;
    uint32_t head = p->palette ? p->palette : p->base;
    uint8_t value[COHSM__MARKS], place[COHSM__MARKS];
    cohsm__fields f;

    cohsm__put_bits(block, 0, 16, head | p->k << 8 | (p->palette ? p->bits + COHSM__WIDEST : p->bits) << 12);
    f = cohsm__block_fields(block, p->n);
    if (p->palette) cohsm__pierce(s, p->n, grid, value, place);
    for (i = 0; i < p->n; i++) {
        offset = (uint32_t)s[i].first - s[0].first;
        at += (offset >> p->k) - bucket;
        bucket = offset >> p->k;
        cohsm__put_bits(block, at++, 1, 1);
        cohsm__put_bits(block, COHSM__LOW_AT + i * p->k, p->k, offset & ((1u << p->k) - 1u));
        code = s[i].exact ? (1u << p->bits) - 1u : p->palette ? place[i] : cohsm__range_code(s + i, p, grid);
        cohsm__put_bits(block, f.codes_at + i * f.bits, f.bits, code);
        if (s[i].exact) {
            cohsm__put_bits(block, f.exact_at, 16, s[i].lo);
            f.exact_at += 16;
        }
    }
    for (i = 0; i < p->palette; i++) cohsm__put_bits(block, f.palette_at + 8 * i, 8, value[i]);
}

/* Returns the most blocks that a list of count segments can have: a block takes 10 segments at least, all of
   them exact, or all that are left. */
static size_t cohsm__blocks_bound(size_t count) { return count / 10 + 1; }

static size_t cohsm__list_bound(size_t count)
{
    return (cohsm__blocks_bound(count) + 2) / 2 + COHSM__BLOCK_WORDS * cohsm__blocks_bound(count);
}

/* Writes a list of two or more segments into zeroed words as the builder keeps it: 16-bit count of blocks and
   first views of all but the first, padded to a word, then the blocks. Returns the words taken. The blocks
   are written after the longest possible beginning first, and then moved to the end of the real one. */
static size_t cohsm__write_list(uint32_t *words, const cohsm__segment *s, size_t count,
                                const cohsm__grid *grid, uint32_t views)
{
    size_t i, blocks = 0;
    size_t gap = (cohsm__blocks_bound(count) + 2) / 2, used = 0, directory;
    cohsm__plan p;

    for (i = 0; i < count; i += p.n, blocks++) {
        p = cohsm__plan_block(s + i, count - i, grid, views);
        if (blocks) cohsm__put_bits(words, 16u * (uint32_t)blocks, 16, s[i].first);
        cohsm__write_block(words + gap + used, s + i, &p, grid);
        used += i + p.n < count ? (uint32_t)COHSM__BLOCK_WORDS : (p.size + 31u) / 32u;
    }
    cohsm__put_bits(words, 0, 16, (uint32_t)blocks);
    directory = (blocks + 1) / 2;
    memmove(words + directory, words + gap, 4 * used);
    memset(words + directory + used, 0, 4 * (gap - directory));
    return directory + used;
}
