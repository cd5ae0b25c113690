/* ---- pack: a list as its neighbours foresee it ---- */

/* A list that is taken apart into its segments. */
typedef struct cohsm__strip {
    uint32_t        count;              /* segments; 0: there is no such pixel */
    cohsm__segment *s;                  /* lo = hi is the grid value; of an exact depth lo is that depth, and
                                           hi the grid value at or below it */
    uint32_t       *breaks;             /* bit COHSM__MARGIN + i is set if a segment begins at view i > 0 */
} cohsm__strip;

enum { COHSM__LEFT, COHSM__UP, COHSM__UP_LEFT, COHSM__UP_RIGHT, COHSM__SELF, COHSM__STRIPS };
enum { COHSM__MARGIN = 32, COHSM__REACH = 2, COHSM__NEAR = 1 << (2 * COHSM__REACH + 1), COHSM__RUNS = 8,
       COHSM__BREAK_WORDS = (COHSM__MARGIN + 65536 + COHSM__REACH) / 32 + 2 };

typedef struct cohsm__odds {            /* the adaptive probabilities of all bits, by their contexts */
    cohsm__prob hot[COHSM__NEAR * COHSM__NEAR * 3 * COHSM__RUNS];
    cohsm__prob cold[32 * 32], cold_length[32 * COHSM__NUMBER];
    cohsm__prob exact[3], repeat[128], left[64], up[8];
    cohsm__prob below[16], error[32 * COHSM__NUMBER];
    cohsm__prob more[16 * 64];
    uint32_t breaks[COHSM__STRIPS][COHSM__BREAK_WORDS];     /* of the strips */
} cohsm__odds;

typedef struct cohsm__packer {          /* the work on one block, of encoder or decoder */
    cohsm__coder  c;
    cohsm__odds *m;
    cohsm__strip  strip[COHSM__STRIPS];         /* of the pixel at hand and its neighbours */
    cohsm__segment *segments;                   /* memory of the strips, then of taken */
    uint32_t      longest, width, views;        /* segments of the longest list; words of strip.breaks; views
                                                   of the chunk */
    cohsm__grid   grid;
    uint32_t     *list;                         /* one list on its way out of the decoder */
    uint8_t      *taken;                        /* segments in each block of strip[COHSM__SELF] */
    int           bad;                          /* the decoder met what no encoder writes */
} cohsm__packer;

static uint32_t cohsm__grid_depth(uint32_t value, uint32_t grid)
{
    return value < grid ? value * 65535u / grid : (uint32_t)COHSM__INFINITE;
}

static void cohsm__strip_clear(cohsm__strip *t)
{
    uint32_t i;
    for (i = 1; i < t->count; i++) t->breaks[(COHSM__MARGIN + t->s[i].first) >> 5] = 0;
    t->count = 0;
}

static void cohsm__strip_breaks(cohsm__strip *t)
{
    uint32_t i;
    for (i = 1; i < t->count; i++) cohsm__put_bits(t->breaks, COHSM__MARGIN + t->s[i].first, 1, 1);
}

/* Appends the segments of one block to a strip. */
static void cohsm__strip_block(const cohsm__packer *p, cohsm__strip *t, const uint32_t *block, uint32_t first)
{
    uint64_t marks = cohsm__marks(block);
    uint32_t n = cohsm__popcount(marks), bucket = 0;
    uint32_t j, code, exact_at;
    cohsm__fields f = cohsm__block_fields(block, n);
    uint32_t ones = (1u << f.bits) - 1u;

    for (j = 0, exact_at = f.exact_at; j < n; marks >>= 1) {
        cohsm__segment *s = &t->s[t->count];
        if (!(marks & 1u)) {
            bucket++;
            continue;
        }
        s->first = (uint16_t)(first + (bucket << f.k) + cohsm__bits(block, COHSM__LOW_AT + j * f.k, f.k));
        code = cohsm__bits(block, f.codes_at + j * f.bits, f.bits);
        s->exact = code == ones;
        if (s->exact) {
            code = cohsm__bits(block, exact_at, 16);
            exact_at += 16;
        } else if (f.palette) code = cohsm__bits(block, f.palette_at + 8 * code, 8);
        else code = code + 1u == ones ? p->grid.top : code + (block[0] & 255u);
        s->lo = (uint16_t)(s->exact ? code : cohsm__min_u32(code, p->grid.top));
        s->hi = (uint16_t)(s->exact ? cohsm__grid_below(code, p->grid.top) : s->lo);
        t->count++;
        j++;
    }
}

/* Where the lists of a block are. A decoder reads there the lists that it wrote before. */
typedef struct cohsm__lists { const uint32_t *lookup, *directories, *lines; } cohsm__lists;

static cohsm__lists cohsm__lists_of(const cohsm__header *h, const uint32_t *words)
{
    cohsm__lists l;
    l.lookup = words + COHSM__HEADER_WORDS + h->order_words + h->location_words;
    l.directories = l.lookup + h->lookup_words;
    l.lines = l.directories + h->directory_words;
    return l;
}

static void cohsm__strip_constant(const cohsm__packer *p, cohsm__strip *t, uint32_t depth)
{
    uint32_t value = cohsm__grid_above(depth, p->grid.top);
    t->s[0].first = 0;
    t->s[0].exact = cohsm__grid_depth(value, p->grid.top) != depth;
    t->s[0].lo = (uint16_t)(t->s[0].exact ? depth : value);
    t->s[0].hi = (uint16_t)(t->s[0].exact ? cohsm__grid_below(depth, p->grid.top) : value);
    t->count = 1;
}

/* Reads a list into a strip; taken, which may be NULL, receives how many segments each block has. */
static void cohsm__strip_read(const cohsm__packer *p, cohsm__strip *t, const cohsm__lists *l, size_t index,
                              uint8_t *taken)
{
    uint32_t entry = l->lookup[index], b, before;
    const uint32_t *directory = l->directories + entry;

    cohsm__strip_clear(t);
    if (entry & COHSM__CONSTANT) cohsm__strip_constant(p, t, entry & 0xffffu);
    else
        for (b = 0; b < cohsm__block_count(directory); b++) {
            before = t->count;
            cohsm__strip_block(p, t, cohsm__block_at(directory, l->lines, b),
                               b ? cohsm__block_first(directory, b) : 0u);
            if (taken) taken[b] = (uint8_t)(t->count - before);
        }
    cohsm__strip_breaks(t);
}

/* Returns 33 bits or more from any position, which is more than any field needs. */
static uint64_t cohsm__window(const uint32_t *words, uint32_t bit)
{
    const uint32_t *w = words + (bit >> 5);
    return (w[0] | (uint64_t)w[1] << 32) >> (bit & 31u);
}

/* Returns the breaks of a strip from view - COHSM__REACH on, as bits, 33 of them or more. */
static uint64_t cohsm__breaks_near(const cohsm__strip *t, uint32_t view)
{
    return cohsm__window(t->breaks, COHSM__MARGIN + view - COHSM__REACH);
}

/* Returns the first view at or after this one that has a break of either neighbour within reach, at most
   p->views. */
static uint32_t cohsm__next_hot(const cohsm__packer *p, uint32_t view)
{
    const uint32_t *a = p->strip[COHSM__LEFT].breaks, *b = p->strip[COHSM__UP].breaks;
    uint32_t at = COHSM__MARGIN + view + COHSM__REACH, i = at >> 5, word;

    if (i >= p->width) return p->views;
    for (word = (a[i] | b[i]) >> (at & 31u) << (at & 31u); !word; word = a[i] | b[i])
        if (++i == p->width) return p->views;
    at = 32 * i + cohsm__popcount((word & (0u - word)) - 1u);
    return at - COHSM__MARGIN - COHSM__REACH;
}

/* Codes one by one whether the segment ends at a view, for views next to a break of the left or the upper
   list. Returns the first view that is not next to one, or the one where the segment ends, with *ended. */
static uint32_t cohsm__code_hot(cohsm__packer *p, uint32_t first, uint32_t view, uint32_t next, int *ended)
{
    uint64_t left = cohsm__breaks_near(&p->strip[COHSM__LEFT], view);
    uint64_t up = cohsm__breaks_near(&p->strip[COHSM__UP], view);
    uint64_t right = cohsm__breaks_near(&p->strip[COHSM__UP_RIGHT], view);
    uint32_t stop = cohsm__min_u32(p->views, view + 33u - 2 * COHSM__REACH);
    uint32_t run = cohsm__bit_length(view - first), l, u, r;
    cohsm__prob *odds;

    for (; view < stop; view++, left >>= 1, up >>= 1, right >>= 1) {
        l = (uint32_t)left & (COHSM__NEAR - 1u);
        u = (uint32_t)up & (COHSM__NEAR - 1u);
        r = (uint32_t)right & (COHSM__NEAR - 1u);
        if (!(l | u)) break;
        if ((view - first) >> run) run++;
        r = r >> COHSM__REACH & 1u ? 2u : r ? 1u : 0u;
        odds = p->m->hot + ((l * COHSM__NEAR + u) * 3u + r) * COHSM__RUNS + cohsm__min_u32(run, COHSM__RUNS) -
               1u;
        *ended = (int)cohsm__code_bit(&p->c, odds, view == next);
        if (*ended) break;
    }
    return view;
}

/* Codes where the segment that began at first ends, and returns that view. Views near a break of a neighbour
   are coded one by one. For a stretch without such views the function codes whether the segment ends in the
   stretch, and if so, where. */
static uint32_t cohsm__code_next(cohsm__packer *p, uint32_t first, uint32_t next)
{
    uint32_t view = first + 1u, gap, hot;
    int ended = 0;

    for (;;) {
        view = cohsm__code_hot(p, first, view, next, &ended);
        if (ended || view >= p->views) return view;
        hot = cohsm__next_hot(p, view);
        if (hot == view) continue;
        gap = cohsm__bit_length(hot - view);
        if (cohsm__code_bit(&p->c, p->m->cold + 32 * gap + cohsm__bit_length(view - first), next < hot)) {
            next = view + cohsm__code_number(&p->c, p->m->cold_length + COHSM__NUMBER * gap, next - view);
            return cohsm__min_u32(next, hot - 1u);
        }
        view = hot;
    }
}

static void cohsm__code_breaks(cohsm__packer *p)
{
    cohsm__strip *t = &p->strip[COHSM__SELF];
    uint32_t count = t->count, i = 0, next;

    if (!p->c.out) t->s[0].first = 0;
    for (;;) {
        next = cohsm__code_next(p, t->s[i].first, p->c.out && i + 1 < count ? t->s[i + 1].first : p->views);
        if (next >= p->views) break;
        if (++i == p->longest) {
            p->bad = 1;
            break;
        }
        t->s[i].first = (uint16_t)next;
    }
    t->count = cohsm__min_u32(i + 1u, p->longest);
    if (!p->c.out) cohsm__strip_breaks(t);
}

/* Returns the grid value that a strip has at a view; the views of successive calls rise. */
static uint32_t cohsm__strip_value(const cohsm__strip *t, uint32_t *at, uint32_t view, uint32_t otherwise)
{
    if (!t->count) return otherwise;
    while (*at + 1u < t->count && t->s[*at + 1u].first <= view) ++*at;
    return t->s[*at].hi;
}

/* Returns the median of left, up and left + up - corner, which continues an edge, or else a plane, through
   three known neighbours. */
static uint32_t cohsm__predict_value(uint32_t left, uint32_t up, uint32_t corner)
{
    uint32_t least = cohsm__min_u32(left, up), most = cohsm__max_u32(left, up);
    return corner >= most ? least : corner <= least ? most : left + up - corner;
}

/* The numbers that are known when the value of a segment is coded: the values of the neighbours at the
   segment's middle, those of the two segments before, whether earlier values were repeated (bits of history),
   and the views of the segment. */
typedef struct cohsm__around { uint32_t left, up, corner, before[2], history, run; } cohsm__around;

/* Codes a value by asking in turn whether it is the value before last, as where two surfaces flicker, or that
   of the left or the upper neighbour, and else by a correction of the prediction. */
static uint32_t cohsm__code_value(cohsm__packer *p, const cohsm__around *a, uint32_t value)
{
    cohsm__odds *m = p->m;
    cohsm__coder *c = &p->c;
    uint32_t last = a->before[1], h = a->history;
    uint32_t guess, below, error, spread;

    if (cohsm__code_bit(c,
                        m->repeat + ((a->left == last ? 1u : 0u) | (a->up == last ? 2u : 0u) | (h & 7u) << 2 |
                                     (a->run == 1 ? 32u : 0u) | (a->before[0] == last ? 64u : 0u)),
                        value == last))
        return last;
    if (a->left != last && cohsm__code_bit(c,
                                           m->left + ((a->up == a->left ? 1u : 0u) | (h & 14u) << 1 |
                                                      (a->before[0] == a->left ? 32u : 0u)),
                                           value == a->left))
        return a->left;
    if (a->up != last && a->up != a->left && cohsm__code_bit(c, m->up + (h & 7u), value == a->up))
        return a->up;
    guess = cohsm__predict_value(a->left, a->up, a->corner);
    spread = cohsm__bit_length(cohsm__max_u32(a->left, a->up) - cohsm__min_u32(a->left, a->up));
    below = cohsm__code_bit(c, m->below + spread, value < guess);
    error = cohsm__code_number(c, m->error + COHSM__NUMBER * (2 * spread + below),
                               below ? guess - value : value - guess);
    return below ? guess - cohsm__min_u32(error, guess) : guess + cohsm__min_u32(error, p->grid.top - guess);
}

static void cohsm__code_values(cohsm__packer *p)
{
    cohsm__strip *t = &p->strip[COHSM__SELF];
    uint32_t at[COHSM__SELF], i;
    uint32_t end, middle, exact = 0;
    cohsm__around a;

    memset(at, 0, sizeof at);
    memset(&a, 0, sizeof a);
    for (i = 0; i < t->count; i++) {
        cohsm__segment *s = &t->s[i];
        end = cohsm__segment_end(t->s, i, t->count, p->views);
        middle = (s->first + end) / 2u;
        a.run = end - s->first;
        a.up = cohsm__strip_value(&p->strip[COHSM__UP], at + COHSM__UP, middle, a.before[1]);
        a.left = cohsm__strip_value(&p->strip[COHSM__LEFT], at + COHSM__LEFT, middle, a.up);
        if (!p->strip[COHSM__UP].count) a.up = a.left;
        a.corner = cohsm__strip_value(&p->strip[COHSM__UP_LEFT], at + COHSM__UP_LEFT, middle, a.up);
        exact = cohsm__code_bit(&p->c, p->m->exact + (a.run > 1 ? 0u : 1u + exact), s->exact);
        if (exact) {
            s->lo = (uint16_t)cohsm__code_raw(&p->c, 16, s->lo);
            s->hi = (uint16_t)cohsm__grid_below(s->lo, p->grid.top);
        } else {
            s->hi = s->lo = (uint16_t)cohsm__code_value(p, &a, s->lo);
            a.history = a.history << 1 | (s->hi == a.before[1]);
        }
        s->exact = (uint16_t)exact;
        a.before[1] = a.before[0];
        a.before[0] = s->hi;
    }
}
