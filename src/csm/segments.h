/* ---- segments: found elsewhere, and written here ---- */

/* While a chunk is taken, b->span holds for each pixel where its last segment begins, or -1. */
static void cohsm__await_segments(cohsm_builder *b)
{
    uint32_t p;
    for (p = 0; p < b->range_pixels; p++) b->span[p] = -1;
}

/* Writes the lists of the chunk that ends before view `end`, after checking that each pixel has a segment. */
static cohsm_result cohsm__end_segments(cohsm_builder *b, uint32_t end, const cohsm__logger *log)
{
    const uint32_t views = ((end - 1u) & (COHSM__CHUNK - 1u)) + 1u;
    cohsm_result result;
    uint32_t p;

    for (p = 0; p < b->range_pixels; p++) {
        if (b->span[p] < 0) {
            cohsm__log_value(log, "the pixel without a segment", (double)(b->desc.pixel_begin + p), "none");
            return COHSM_ERR_INPUT;
        }
        b->first[p] = views;            /* nothing is open */
    }
    b->next_view = end;
    result = cohsm__close_chunk(b);
    cohsm__await_segments(b);
    return result;
}

/* Returns the range of a pixel. */
static cohsm__range *cohsm__range_of(cohsm_builder *b, uint32_t pixel)
{
    uint32_t lo = 0, hi = COHSM__RANGES, middle;
    while (hi - lo > 1u) {
        middle = (lo + hi) / 2u;
        if (b->ranges[middle].begin <= pixel) lo = middle;
        else hi = middle;
    }
    return &b->ranges[lo];
}

/* The segments that are taken, and the number of the one whose turn it is. */
typedef struct cohsm__taking {
    const cohsm_segment *segments;
    size_t               at;
    const cohsm__logger *log;
} cohsm__taking;

static cohsm_result cohsm__refuse_segment(const cohsm__taking *take, const char *what, uint32_t value,
                                          const char *wanted)
{
    cohsm__log_element(take->log, "segments", take->at, what, (double)value, wanted);
    return COHSM_ERR_INPUT;
}

/* Takes one segment, of pixel p of the shard. Returns COHSM_ERR_INPUT if it does not follow the last one. */
static cohsm_result cohsm__take_segment(cohsm_builder *b, const cohsm__taking *take, uint32_t p)
{
    const cohsm_segment *s = &take->segments[take->at];
    const uint32_t first = s->first & (COHSM__CHUNK - 1u), exact = s->value & 65536u;
    const uint32_t lo = s->value & 255u, hi = s->value >> 8 & 255u;
    cohsm__range *r = cohsm__range_of(b, p);

    if (s->value > 131071u || (!exact && (lo > hi || hi > b->grid.top)))
        return cohsm__refuse_segment(take, "has the value", s->value,
                                     "lo | hi << 8 with lo <= hi < 2^depth_bits, or a depth | 1 << 16");
    if (b->span[p] < 0 && first)
        return cohsm__refuse_segment(take, "has the first view", s->first,
                                     "a multiple of 65536, as the first of its pixel");
    if ((int64_t)first <= b->span[p])
        return cohsm__refuse_segment(take, "has the first view", s->first,
                                     "above that of the segment before it of its pixel");
    if (!cohsm__page_ready(b, r, 1)) {
        if (cohsm__take_spares(b) != COHSM_OK) return COHSM_ERR_ALLOC;
        cohsm__page_ready(b, r, 1);
    }
    b->span[p] = (int32_t)first;
    b->first[p] = first;
    cohsm__close_segment(b, r, p, exact ? COHSM__EXACT : 0u, lo, hi);
    r->exact += exact != 0;
    return COHSM_OK;
}

/* Checks what can be told without the other segments of the pixel. */
static cohsm_result cohsm__check_segment(const cohsm_builder *b, const cohsm__taking *take, uint32_t chunk)
{
    const cohsm_segment *s = &take->segments[take->at];
    if (s->pixel >= b->head.map_side * b->head.map_side)
        return cohsm__refuse_segment(take, "has the pixel", s->pixel, "below map_side^2");
    if (s->first >= b->head.view_count)
        return cohsm__refuse_segment(take, "has the first view", s->first, "below the number of views");
    if (s->first >> COHSM__CHUNK_BITS < chunk)
        return cohsm__refuse_segment(take, "has the first view", s->first,
                                     "at or above the multiple of 65536 that others have reached");
    return COHSM_OK;
}

/* Takes all segments in their order, and writes the lists of each chunk when the next one begins. */
static cohsm_result cohsm__take_segments(cohsm_builder *b, cohsm__taking *take, size_t count)
{
    uint32_t chunk = 0;
    cohsm_result result;

    cohsm__await_segments(b);
    for (take->at = 0; take->at < count; take->at++) {
        const cohsm_segment *s = &take->segments[take->at];
        const uint32_t p = s->pixel - b->desc.pixel_begin;
        result = cohsm__check_segment(b, take, chunk);
        while (result == COHSM_OK && s->first >> COHSM__CHUNK_BITS > chunk)
            result = cohsm__end_segments(b, ++chunk << COHSM__CHUNK_BITS, take->log);
        if (result == COHSM_OK && p < b->range_pixels) result = cohsm__take_segment(b, take, p);
        if (result != COHSM_OK) return result;
    }
    return cohsm__end_segments(b, b->head.view_count, take->log);
}

COHSM_DEF cohsm_result cohsm_builder_import(cohsm_builder *b, const cohsm_segment *segments, size_t count)
{
    cohsm__logger log;
    cohsm__taking take;
    cohsm_result result;

    if (!b) return COHSM_ERR_ARGUMENT;
    log = cohsm__logger_of(&b->desc.system, "cohsm_builder_import");
    if (!segments) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "segments", "is NULL");
    if (b->finished || b->next_view || b->batch_count)
        return cohsm__refuse(&log, COHSM_ERR_ORDER, "the builder", "has views, or has ended");
    take.segments = segments;
    take.log = &log;
    result = cohsm__take_segments(b, &take, count);
    if (result == COHSM_OK) b->batch_begin = b->head.view_count;
    else b->finished = 1;
    return cohsm__log_result(&log, result);
}
