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

/* Takes one segment, of pixel p of the shard. Returns COHSM_ERR_INPUT if it does not follow the last one. */
static cohsm_result cohsm__take_segment(cohsm_builder *b, const cohsm_segment *s, uint32_t p)
{
    const uint32_t first = s->first & (COHSM__CHUNK - 1u), exact = s->value & 65536u;
    const uint32_t lo = s->value & 255u, hi = s->value >> 8 & 255u;
    cohsm__range *r = cohsm__range_of(b, p);

    if (s->value > 131071u || (!exact && (lo > hi || hi > b->grid.top))) return COHSM_ERR_INPUT;
    if (b->span[p] < 0 ? first != 0 : (int64_t)first <= b->span[p]) return COHSM_ERR_INPUT;
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

/* Takes all segments in their order, and writes the lists of each chunk when the next one begins. */
static cohsm_result cohsm__take_segments(cohsm_builder *b, const cohsm_segment *segments, size_t count,
                                         const cohsm__logger *log)
{
    uint32_t chunk = 0;
    cohsm_result result = COHSM_OK;
    size_t i;

    cohsm__await_segments(b);
    for (i = 0; i < count && result == COHSM_OK; i++) {
        const cohsm_segment *s = &segments[i];
        const uint32_t p = s->pixel - b->desc.pixel_begin;
        if (s->pixel >= b->head.map_side * b->head.map_side || s->first >= b->head.view_count ||
            s->first >> COHSM__CHUNK_BITS < chunk)
            result = COHSM_ERR_INPUT;
        else if (s->first >> COHSM__CHUNK_BITS > chunk) {
            result = cohsm__end_segments(b, ++chunk << COHSM__CHUNK_BITS, log);
            if (result != COHSM_OK) return result;
            i--;                        /* it may begin a later chunk, too */
            continue;
        }
        if (result == COHSM_OK && p < b->range_pixels) result = cohsm__take_segment(b, s, p);
        if (result == COHSM_ERR_INPUT)
            cohsm__log_element_text(log, "segments", i, "is out of order, or of range");
    }
    return result == COHSM_OK ? cohsm__end_segments(b, b->head.view_count, log) : result;
}

COHSM_DEF cohsm_result cohsm_builder_import(cohsm_builder *b, const cohsm_segment *segments, size_t count)
{
    cohsm__logger log;
    cohsm_result result;

    if (!b) return COHSM_ERR_ARGUMENT;
    log = cohsm__logger_of(&b->desc.system, "cohsm_builder_import");
    if (!segments) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "segments", "is NULL");
    if (b->finished || b->next_view || b->batch_count)
        return cohsm__refuse(&log, COHSM_ERR_ORDER, "the builder", "has views, or has ended");
    result = cohsm__take_segments(b, segments, count, &log);
    if (result == COHSM_OK) b->batch_begin = b->head.view_count;
    else b->finished = 1;
    return cohsm__log_result(&log, result);
}
