/* ---- builder: layers to segments, one view at a time ---- */

enum {
    COHSM__RANGES = 16,
    COHSM__BATCH = 128,                 /* views that are drawn before they are compressed, the most */
    COHSM__BATCH_SIDE = 128             /* M beyond which a batch has a quarter, for want of memory */
};

typedef struct cohsm__record {          /* a closed segment on its way to a list */
    uint32_t pixel;                     /* within the range; top bit: exact, its depth in lo | hi << 8 */
    uint16_t first;
    uint8_t  lo, hi;
} cohsm__record;
#define COHSM__EXACT 0x80000000u

typedef struct cohsm__page {            /* records, in memory for b->page_records of them */
    struct cohsm__page *next;
    uint32_t count;
    cohsm__record records[1];
} cohsm__page;

typedef struct cohsm__range {           /* neighbouring pixels, compressed by one task */
    uint32_t     begin, end;            /* pixels of the shard */
    cohsm__page *first, *last;          /* the records of the chunk so far */
    cohsm__page *spare;                 /* an empty page, taken from the allocator between tasks */
    uint32_t     next_view, next_pixel; /* of the batch, and of that view */
    int          starved;               /* stopped for want of a page */
    uint64_t     segments, exact, empty, open;
} cohsm__range;

/* The lists of one range of pixels in one chunk, in memory for count words. */
typedef struct cohsm__words { struct cohsm__words *next; size_t count; uint32_t data[1]; } cohsm__words;

#ifndef COHSM_WITHOUT_BUILD
struct cohsm_builder {
    cohsm__counted_heap       heap;
    cohsm_desc        desc;             /* defaults filled in */
    cohsm__header     head;
    uint32_t         *cells;            /* place in the sequence -> cell */
    float            *locations, *angles;
    int32_t          *span;             /* of each pixel of the shard: the grid values that its open segment
                                           can have, lo | hi << 16 */
    uint32_t         *first;            /* its first view within the chunk */
    uint16_t         *batch;            /* batch_views views with `keep` values a pixel: z1, z2, z3, and
                                           the depth where the ray leaves the sphere (Z1Z3_SPHERE only) */
    uint32_t          keep, batch_size, batch_views, batch_begin, batch_count;
    uint32_t          next_view, range_pixels, page_records;
    cohsm__grid       grid;
    float             thickness;        /* desc.open_thickness in 16-bit depths; for maps of positions, as a
                                           share of the depth */
    cohsm__range      ranges[COHSM__RANGES];
    cohsm__words     *lists, *lists_last;
    uint32_t         *lookup;           /* words from the beginning of its piece of lists, until finish */
    size_t            list_words;
    int               simd;             /* which kernels compress */
    int               finished;         /* or failed: it can only be freed */
    int               counting;         /* segments are counted alone; lists are not written */
};
#endif

/* What kernels need to know to narrow the open segments of pixels, and what they count meanwhile. Behind a
   first layer without a second, at depth z, there are slope * z + gap depths that may be stored. */
typedef struct cohsm__narrowing {
    int32_t  top;                       /* the greatest grid value */
    int32_t  miss;                      /* the least depth that a pixel without a hit can store */
    float    slope, gap;
    uint64_t empty, open;               /* as in cohsm__range */
} cohsm__narrowing;
enum { COHSM__NARROWED = 256 };         /* the most pixels that a kernel narrows at a time */

/* Grid value i stands for the depth floor(i 65535 / grid). These return the least i whose depth is at least
   d, and the greatest i whose depth is at most d. */
static uint32_t cohsm__grid_above(uint32_t d, uint32_t grid) { return (d * grid + 65534u) / 65535u; }
static uint32_t cohsm__grid_below(uint32_t d, uint32_t grid) { return ((d + 1u) * grid - 1u) / 65535u; }

/* Ends the open segment of a pixel. With flag 0 its depth is a grid value within lo..hi. A depth right before
   the second layer would let that layer be lit under a bias of one pixel, so the depth stays up to two pixels
   away from that layer, as long as four are left behind the first. */
static void cohsm__close_segment(cohsm_builder *b, cohsm__range *r, uint32_t pixel, uint32_t flag,
                                 uint32_t lo, uint32_t hi)
{
    cohsm__record *c = &r->last->records[r->last->count++];
    uint32_t clear = b->head.positional ? 4u * hi / b->head.map_side + 1u : b->grid.margin;
    if (!flag && hi < b->grid.top)
        hi = hi > lo + 3u * clear ? hi - clear : cohsm__min_u32(hi, lo + 2u * clear);
    c->pixel = (pixel - r->begin) | flag;
    c->first = (uint16_t)b->first[pixel];
    c->lo = (uint8_t)lo;
    c->hi = (uint8_t)hi;
    r->segments++;
}

/* The grid values lo..hi that an open segment can have, in one number. */
static int32_t cohsm__span_pack(uint32_t lo, uint32_t hi) { return (int32_t)(lo | hi << 16); }
static uint32_t cohsm__span_lo(int32_t span) { return (uint32_t)span & 65535u; }
static uint32_t cohsm__span_hi(int32_t span) { return (uint32_t)span >> 16; }

static void cohsm__close_open_segment(cohsm_builder *b, cohsm__range *r, uint32_t pixel)
{
    cohsm__close_segment(b, r, pixel, 0, cohsm__span_lo(b->span[pixel]), cohsm__span_hi(b->span[pixel]));
}

/* Makes sure that the last page of a range has room for the records of so many pixels of one view, which may
   close two segments a pixel: the one that was open before, and one of an exact depth. Returns 0 if a new
   page is needed and there is no spare one. Who counts segments alone keeps no records. */
static int cohsm__page_ready(const cohsm_builder *b, cohsm__range *r, uint32_t pixels)
{
    cohsm__page *p = r->last;
    if (p && b->counting) p->count = 0;
    if (p && p->count + 2 * pixels <= b->page_records) return 1;
    if (!r->spare) return 0;
    p = r->spare;
    r->spare = NULL;
    p->next = NULL;
    p->count = 0;
    if (r->last) r->last->next = p;
    else r->first = p;
    r->last = p;
    return 1;
}

/* Writes the interval [lo, hi] in which a stored depth must lie: from the first hit to just before the layer
   that bounds it. Returns 1 if that layer lies at the first hit: then z = z1, and the query's bias has to
   keep the surface from shadowing itself. */
static int cohsm__interval(const cohsm_builder *b, const uint16_t *z, uint32_t *lo, uint32_t *hi)
{
    uint32_t z2 = z[1], upper;

    *lo = z[0];
    *hi = COHSM__INFINITE;
    if (z[0] == COHSM__INFINITE) {
        if (b->desc.self_only) *lo = 0;
        return 0;
    }
    if (b->desc.layers == COHSM_LAYERS_Z1Z2) {
        upper = z2;
        if (z2 == COHSM__INFINITE)
            upper = z[0] + 1u + (uint32_t)(b->head.positional ? b->thickness * (float)z[0] : b->thickness);
    } else if (z[2] != COHSM__INFINITE) upper = z[2];
    else if (b->desc.layers == COHSM_LAYERS_Z1Z3_FAR) return 0;
    else upper = cohsm__max_u32(z[3], z2 == COHSM__INFINITE ? z[0] : z2) + 1u;
    *hi = upper > z[0] ? cohsm__min_u32(upper - 1u, COHSM__OPEN) : z[0];
    return upper <= z[0];
}

static size_t cohsm__page_size(const cohsm_builder *b)
{
    return sizeof(cohsm__page) + (size_t)b->page_records * sizeof(cohsm__record);
}

/* Gets a spare page for each range. Allocation happens here, between tasks, since the caller's allocator need
   not be safe to call from several threads. */
static cohsm_result cohsm__take_spares(cohsm_builder *b)
{
    int i;
    for (i = 0; i < COHSM__RANGES; i++) {
        cohsm__range *r = &b->ranges[i];
        if (r->spare || r->begin == r->end) continue;
        r->spare = (cohsm__page *)cohsm__heap_alloc(&b->heap, 1, cohsm__page_size(b));
        if (!r->spare) return COHSM_ERR_ALLOC;
        r->spare->next = NULL;
    }
    return COHSM_OK;
}

static void cohsm__free_pages(cohsm_builder *b, cohsm__page *p)
{
    while (p) {
        cohsm__page *next = p->next;
        cohsm__heap_free(&b->heap, p, 1, cohsm__page_size(b));
        p = next;
    }
}

static cohsm__segment cohsm__segment_of(const cohsm__record *c)
{
    cohsm__segment s;
    s.exact = (c->pixel & COHSM__EXACT) != 0;
    s.first = c->first;
    s.lo = s.exact ? (uint16_t)((uint32_t)c->lo | (uint32_t)c->hi << 8) : (uint16_t)c->lo;
    s.hi = c->hi;
    return s;
}

static uint32_t cohsm__constant_entry(const cohsm__segment *s, const cohsm__grid *grid)
{
    uint32_t value = grid->top;
    if (s->exact) return COHSM__CONSTANT | s->lo;
    if (s->lo < grid->top) value = cohsm__choose_value(grid, s->lo, cohsm__min_u32(s->hi, grid->top - 1u));
    return COHSM__CONSTANT | value * 65535u / grid->top;
}

/* Lists on their way from the records of a range to words. As many ranges as COHSM__WRITERS are written side
   by side: with four, a build from random triangles would take more memory than cohsm_build says. */
enum { COHSM__WRITERS = 2 };
typedef struct cohsm__writer {
    const cohsm__range *r;
    uint32_t           *lookup;         /* of the pixels of the range */
    size_t             *at;             /* for each pixel and one more: its first segment */
    cohsm__segment     *segments;       /* by pixel; views are in order already */
    cohsm__words       *words;          /* room for `bound` of them */
    size_t              total, bound;
} cohsm__writer;

typedef struct cohsm__writing {
    const cohsm_builder *builder;
    uint32_t             views;
    cohsm__writer        writer[COHSM__WRITERS];
} cohsm__writing;

/* Counts the segments of each pixel, and finds where they shall begin. */
static void cohsm__count_task(void *context, size_t index)
{
    cohsm__writer *w = &((cohsm__writing *)context)->writer[index];
    const uint32_t pixels = w->r->end - w->r->begin;
    const cohsm__page *page;
    uint32_t p, i;

    memset(w->at, 0, ((size_t)pixels + 1) * sizeof *w->at);
    for (page = w->r->first; page; page = page->next)
        for (i = 0; i < page->count; i++) w->at[page->records[i].pixel & ~COHSM__EXACT]++;
    for (p = 0; p < pixels; p++) {
        w->bound += w->at[p] > 1 ? cohsm__list_bound(w->at[p]) : 0;
        w->total += w->at[p];
        w->at[p] = w->total - w->at[p];
    }
    w->at[pixels] = w->total;
}

/* Sorts the records of a range by pixel, and writes one list after the other. */
static void cohsm__write_task(void *context, size_t index)
{
    cohsm__writing *writing = (cohsm__writing *)context;
    const cohsm__grid *grid = &writing->builder->grid;
    cohsm__writer *w = &writing->writer[index];
    const uint32_t pixels = w->r->end - w->r->begin;
    const cohsm__page *page;
    size_t used = 0, n = 0;
    uint32_t p, i;

    for (page = w->r->first; page; page = page->next)
        for (i = 0; i < page->count; i++)
            w->segments[w->at[page->records[i].pixel & ~COHSM__EXACT]++] =
                cohsm__segment_of(&page->records[i]);
    memset(w->words->data, 0, 4 * w->bound);
    for (p = 0; p < pixels; n = w->at[p++]) {           /* at[p] is the end of list p by now */
        if (w->at[p] - n == 1) {
            w->lookup[p] = cohsm__constant_entry(w->segments + n, grid);
            continue;
        }
        w->lookup[p] = (uint32_t)used;
        used += cohsm__write_list(w->words->data + used, w->segments + n, w->at[p] - n, grid, writing->views);
    }
    w->words->count = used;
}

/* Appends the lists of a range to those of the builder, without what their bound had too much. */
static cohsm_result cohsm__keep_lists(cohsm_builder *b, const cohsm__words *words)
{
    const size_t used = words->count;
    cohsm__words *exact = (cohsm__words *)cohsm__heap_alloc(&b->heap, 1, sizeof *exact + 4 * used);
    if (!exact) return COHSM_ERR_ALLOC;
    exact->next = NULL;
    exact->count = used;
    memcpy(exact->data, words->data, 4 * used);
    if (b->lists_last) b->lists_last->next = exact;
    else b->lists = exact;
    b->lists_last = exact;
    b->list_words += used;
    return COHSM_OK;
}

/* Writes the lists of `count` ranges. The caller's allocator is asked between tasks, as in
   cohsm__take_spares. */
static cohsm_result cohsm__write_ranges(cohsm_builder *b, cohsm__writing *writing, uint32_t count)
{
    cohsm_result result = COHSM_OK;
    uint32_t i;

    for (i = 0; i < count && result == COHSM_OK; i++) {
        cohsm__writer *w = &writing->writer[i];
        w->at = (size_t *)cohsm__heap_alloc(&b->heap, (size_t)(w->r->end - w->r->begin) + 1, sizeof *w->at);
        if (!w->at) result = COHSM_ERR_ALLOC;
    }
    if (result == COHSM_OK) cohsm__run_tasks(&b->desc.system, count, cohsm__count_task, writing);
    for (i = 0; i < count && result == COHSM_OK; i++) {
        cohsm__writer *w = &writing->writer[i];
        w->segments = (cohsm__segment *)cohsm__heap_alloc(&b->heap, w->total, sizeof *w->segments);
        w->words = (cohsm__words *)cohsm__heap_alloc(&b->heap, 1, sizeof *w->words + 4 * w->bound);
        if (!w->segments || !w->words) result = COHSM_ERR_ALLOC;
    }
    if (result == COHSM_OK) cohsm__run_tasks(&b->desc.system, count, cohsm__write_task, writing);
    for (i = 0; i < count; i++) {
        cohsm__writer *w = &writing->writer[i];
        if (result == COHSM_OK) result = cohsm__keep_lists(b, w->words);
        cohsm__heap_free(&b->heap, w->words, 1, sizeof *w->words + 4 * w->bound);
        cohsm__heap_free(&b->heap, w->segments, w->total, sizeof *w->segments);
        cohsm__heap_free(&b->heap, w->at, (size_t)(w->r->end - w->r->begin) + 1, sizeof *w->at);
    }
    return result;
}

/* Closes the open segments of a range of pixels. */
static void cohsm__close_range(cohsm_builder *b, cohsm__range *r, uint32_t views)
{
    uint32_t p;
    cohsm__page_ready(b, r, r->end - r->begin);
    for (p = r->begin; p < r->end; p++) {
        if (b->first[p] != views) cohsm__close_open_segment(b, r, p);
        b->first[p] = 0;
        b->span[p] = cohsm__span_pack(0, b->grid.top);
    }
}

/* Ends a chunk of views: closes every segment and turns the records into lists. */
static cohsm_result cohsm__close_chunk(cohsm_builder *b)
{
    const uint32_t chunk = (b->next_view - 1u) >> COHSM__CHUNK_BITS;
    const uint32_t views = ((b->next_view - 1u) & (COHSM__CHUNK - 1u)) + 1u;
    uint32_t *lookup = b->lookup + (size_t)chunk * b->range_pixels, i, k, count;
    cohsm_result result = cohsm__take_spares(b);
    cohsm__writing writing;

    for (i = 0; i < COHSM__RANGES && result == COHSM_OK; i += COHSM__WRITERS) {
        memset(&writing, 0, sizeof writing);
        writing.builder = b;
        writing.views = views;
        for (k = i, count = 0; k < i + COHSM__WRITERS; k++) {
            cohsm__range *r = &b->ranges[k];
            if (r->begin == r->end) continue;           /* fewer pixels than ranges */
            cohsm__close_range(b, r, views);
            writing.writer[count].r = r;
            writing.writer[count++].lookup = lookup + r->begin;
        }
        if (!b->counting) result = cohsm__write_ranges(b, &writing, count);
        for (k = i; k < i + COHSM__WRITERS; k++) {
            cohsm__free_pages(b, b->ranges[k].first);
            b->ranges[k].first = b->ranges[k].last = NULL;
        }
    }
    return result;
}
