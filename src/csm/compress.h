/* ---- compress: the views of a batch to segments ---- */

/* Adds one pixel of a view to the open segment of that pixel, greedily: a segment goes on as long as one grid
   value separates the layers of all its views (equation 1). No sequence of segments is shorter: any part of a
   segment that can be stored can be stored too, so by induction the greedy segments end no earlier than those
   of any other sequence. A view that no grid value separates is a segment of its own, and stored exactly, in
   every sequence. */
static void cohsm__compress_pixel(cohsm_builder *b, cohsm__range *r, uint32_t p, const uint16_t *z,
                                  uint32_t view)
{
    uint32_t lo, hi, depth;              /* what the view at hand can store */
    uint32_t grid_lo, grid_hi;           /* the same on the grid */
    uint32_t both_lo, both_hi;           /* what the open segment can store with this view in it */

    r->empty += (uint64_t)cohsm__interval(b, z, &lo, &hi);
    r->open += z[0] != COHSM__INFINITE && z[1] == COHSM__INFINITE;
    grid_lo = cohsm__grid_above(lo, b->grid.top);
    grid_hi = cohsm__grid_below(hi, b->grid.top);
    both_lo = cohsm__max_u32(cohsm__span_lo(b->span[p]), grid_lo);
    both_hi = cohsm__min_u32(cohsm__span_hi(b->span[p]), grid_hi);
    if (both_lo > both_hi) {
        if (b->first[p] != view) cohsm__close_open_segment(b, r, p);
        b->first[p] = view;
        both_lo = grid_lo;
        both_hi = grid_hi;
        if (grid_lo > grid_hi) {
            depth = (lo + hi) / 2u;
            cohsm__close_segment(b, r, p, COHSM__EXACT, depth & 255u, depth >> 8);
            r->exact++;
            b->first[p] = view + 1u;
            both_lo = 0;
            both_hi = b->grid.top;
        }
    }
    b->span[p] = cohsm__span_pack(both_lo, both_hi);
}

/* Returns what the kernels need to know of a build, see cohsm__narrowing. */
static cohsm__narrowing cohsm__narrowing_of(const cohsm_builder *b)
{
    cohsm__narrowing n;
    n.top = (int32_t)b->grid.top;
    n.miss = b->desc.self_only ? 0 : (int32_t)COHSM__INFINITE;
    n.slope = b->head.positional ? b->thickness : 0.0f;
    n.gap = b->head.positional ? 0.0f : b->thickness;
    n.empty = n.open = 0;
    return n;
}

/* Adds a view to the segments of a range of pixels. Of nine open segments eight or more go on: kernels narrow
   them together, some hundred pixels at a time, and list the pixels that are left: those whose segment ends,
   and the last few. Kernels take two layers, and read both as one word, the first layer in its low half.
   Returns 0 if it stopped before r->next_pixel for want of a page. */
static int cohsm__compress_view(cohsm_builder *b, cohsm__range *r, const cohsm__kernels *kernels,
                                const uint16_t *z, uint32_t view)
{
    const int together = b->keep == 2 && cohsm__host_is_little_endian();
    cohsm__narrowing n = cohsm__narrowing_of(b);
    int32_t left[COHSM__NARROWED + 16];
    uint32_t i, count, pixels;

    for (; r->next_pixel < r->end; r->next_pixel += pixels) {
        const uint32_t p = r->next_pixel;
        const uint16_t *from = z + (size_t)p * b->keep;
        pixels = cohsm__min_u32((uint32_t)COHSM__NARROWED, r->end - p);
        if (!cohsm__page_ready(b, r, pixels)) break;
        if (together) {
            count = kernels->narrow(&n, from, b->span + p, pixels, left);
            for (i = 0; i < count; i++)
                cohsm__compress_pixel(b, r, p + (uint32_t)left[i], from + 2 * left[i], view);
        } else for (i = 0; i < pixels; i++)
            cohsm__compress_pixel(b, r, p + i, from + (size_t)i * b->keep, view);
    }
    r->empty += n.empty;
    r->open += n.open;
    return r->next_pixel == r->end;
}

static void cohsm__compress_task(void *context, size_t index)
{
    cohsm_builder *b = (cohsm_builder *)context;
    cohsm__range *r = &b->ranges[index];
    const uint32_t chunk_begin = b->batch_begin & ~(COHSM__CHUNK - 1u);
    const uint16_t *z = b->batch + (size_t)b->desc.pixel_begin * b->keep;
    const cohsm__kernels kernels = cohsm__choose_kernels(b->simd);

    if (r->begin == r->end) return;                 /* fewer pixels than ranges */
    for (; r->next_view < b->batch_count; r->next_view++, r->next_pixel = r->begin) {
        r->starved = !cohsm__compress_view(b, r, &kernels, z + (size_t)r->next_view * b->batch_size,
                                           b->batch_begin + r->next_view - chunk_begin);
        if (r->starved) return;
    }
}

static cohsm_result cohsm__compress_batch(cohsm_builder *b)
{
    int i, starved;

    for (i = 0; i < COHSM__RANGES; i++) {
        b->ranges[i].next_view = 0;
        b->ranges[i].next_pixel = b->ranges[i].begin;
    }
    do {
        if (cohsm__take_spares(b) != COHSM_OK) return COHSM_ERR_ALLOC;
        cohsm__run_tasks(&b->desc.system, COHSM__RANGES, cohsm__compress_task, b);
        for (i = 0, starved = 0; i < COHSM__RANGES; i++) starved |= b->ranges[i].starved;
    } while (starved);
    return COHSM_OK;
}

