/* ---- builder: made of a desc, given views one by one, and finished ---- */

COHSM_DEF void cohsm_builder_free(cohsm_builder *b)
{
    cohsm__words *w, *next;
    cohsm__counted_heap heap;
    uint32_t n;
    int i;

    if (!b) return;
    n = b->range_pixels;
    for (w = b->lists; w; w = next) {
        next = w->next;
        cohsm__heap_free(&b->heap, w, 1, sizeof *w + 4 * w->count);
    }
    for (i = 0; i < COHSM__RANGES; i++) {
        cohsm__free_pages(b, b->ranges[i].first);
        cohsm__free_pages(b, b->ranges[i].spare);
    }
    cohsm__heap_free(&b->heap, b->batch, (size_t)b->batch_size * b->batch_views, sizeof *b->batch);
    cohsm__heap_free(&b->heap, b->lookup, (size_t)n * cohsm__chunks(&b->head), sizeof *b->lookup);
    cohsm__heap_free(&b->heap, b->first, n, sizeof *b->first);
    cohsm__heap_free(&b->heap, b->span, n, sizeof *b->span);
    cohsm__heap_free(&b->heap, b->angles, 2 * ((size_t)b->head.side[0] + b->head.side[1]), sizeof(float));
    cohsm__heap_free(&b->heap, b->locations, b->head.location_words, sizeof(float));
    cohsm__heap_free(&b->heap, b->cells, b->head.map_count, sizeof *b->cells);
    heap = b->heap;
    cohsm__heap_free(&heap, b, 1, sizeof *b);
}

/* Copies the locations of the desc, and normalises those that are directions. A direction that is unit but
   for rounding stays as it is: the desc of a built block must give the same rays again. */
static void cohsm__copy_locations(float *out, const cohsm_domain *d)
{
    size_t i;
    for (i = 0; i < d->location_count; i++) {
        cohsm__v3 p = cohsm__v3_load(d->locations + 4 * i);
        if (d->locations[3] == 0.0f && fabsf(cohsm__v3_dot(p, p) - 1.0f) > 1e-6f) p = cohsm__v3_normalize(p);
        cohsm__v3_store(out + 4 * i, p);
        out[4 * i + 3] = d->locations[3];
    }
}

static void cohsm__split_ranges(cohsm_builder *b)
{
    uint32_t n = b->range_pixels, i, widest = (n + COHSM__RANGES - 1) / COHSM__RANGES;
    for (i = 0; i < COHSM__RANGES; i++) {
        b->ranges[i].begin = (uint32_t)((uint64_t)n * i / COHSM__RANGES);
        b->ranges[i].end = (uint32_t)((uint64_t)n * (i + 1) / COHSM__RANGES);
    }
    b->page_records = cohsm__max_u32(4 * widest, 256);
}

static void cohsm__drop_builder(cohsm_builder *b, cohsm__counted_heap *heap)
{
    heap->peak = b->heap.peak;
    heap->used -= sizeof *b;
    cohsm_builder_free(b);
}

/* Returns how many views a batch has: with threads as many as give each of 16 one column of them. */
static uint32_t cohsm__batch_views(const cohsm_desc *d)
{
    if (d->map_side > (uint32_t)COHSM__BATCH_SIDE) return (uint32_t)COHSM__BATCH / 4u;
    return (uint32_t)COHSM__BATCH / (d->system.parallel_for ? 1u : 2u);
}

/* Makes a builder of a desc that is checked and complete. On success the builder's heap takes over what heap
   had counted. */
static cohsm_result cohsm__builder_make(const cohsm_desc *desc, cohsm__counted_heap *heap,
                                        cohsm_builder **out)
{
    cohsm_builder *b = (cohsm_builder *)cohsm__heap_alloc(heap, 1, sizeof *b);
    uint32_t n = desc->pixel_end - desc->pixel_begin, i;
    size_t lookup;

    if (!b) return COHSM_ERR_ALLOC;
    memset(b, 0, sizeof *b);
    b->desc = *desc;
    cohsm__fill_header(&b->head, desc);
    b->heap = *heap;
    b->range_pixels = n;
    b->simd = cohsm__simd();
    b->grid = cohsm__grid_of(desc->depth_bits, desc->map_side);
    b->thickness = desc->open_thickness * (b->head.positional ? 2.0f : 65536.0f) / (float)desc->map_side;
    b->keep = desc->layers == COHSM_LAYERS_Z1Z2 ? 2 : 4;
    b->batch_size = desc->map_side * desc->map_side * b->keep;
    b->batch_views = cohsm__batch_views(desc);
    if (!cohsm__mul_size(n, cohsm__chunks(&b->head), &lookup) || lookup > UINT32_MAX / 4) {
        cohsm__heap_free(heap, b, 1, sizeof *b);
        return COHSM_ERR_LIMIT;
    }
    b->cells = (uint32_t *)cohsm__heap_alloc(&b->heap, b->head.map_count, sizeof *b->cells);
    b->angles =
        (float *)cohsm__heap_alloc(&b->heap, 2 * ((size_t)b->head.side[0] + b->head.side[1]), sizeof(float));
    if (b->head.location_words)
        b->locations = (float *)cohsm__heap_alloc(&b->heap, b->head.location_words, sizeof(float));
    b->span = (int32_t *)cohsm__heap_alloc(&b->heap, n, sizeof *b->span);
    b->first = (uint32_t *)cohsm__heap_alloc(&b->heap, n, sizeof *b->first);
    b->lookup = (uint32_t *)cohsm__heap_alloc(&b->heap, lookup, sizeof *b->lookup);
    b->batch =
        (uint16_t *)cohsm__heap_alloc(&b->heap, (size_t)b->batch_size * b->batch_views, sizeof *b->batch);
    cohsm__split_ranges(b);
    if (!b->cells || !b->angles || (b->head.location_words && !b->locations) || !b->span ||
        !b->first || !b->lookup || !b->batch) {
        cohsm__drop_builder(b, heap);
        return COHSM_ERR_ALLOC;
    }
    for (i = 0; i < n; i++) b->span[i] = cohsm__span_pack(0, b->grid.top);
    memset(b->first, 0, n * sizeof *b->first);
    memset(b->lookup, 0, lookup * sizeof *b->lookup);
    cohsm__order_cells(b->cells, b->head.side, desc->order);
    if (b->locations) cohsm__copy_locations(b->locations, &desc->domain);
    cohsm__latlong_angles(b->head.side, b->angles);
    cohsm__dop_of_sphere(b->head.dop, b->head.center, b->head.radius);
    if (b->head.positional) b->head.depth_far = cohsm__far_distance(&b->head, b->locations);
    if (!cohsm__floats_finite(&b->head)) {
        cohsm__drop_builder(b, heap);
        return COHSM_ERR_DESC;
    }
    *out = b;
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_builder_create(const cohsm_desc *desc, cohsm_builder **out)
{
    cohsm_desc d;
    cohsm__counted_heap heap;
    cohsm__logger log;
    cohsm_result result;

    if (!desc) return COHSM_ERR_ARGUMENT;
    d = *desc;
    log = cohsm__logger_of(&d.system, "cohsm_builder_create");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    result = cohsm__check_desc(&d, &log);
    if (result != COHSM_OK) return result;
    if (!cohsm__radius_usable(d.radius))
        return cohsm__refuse_value(&log, "desc.radius", (double)d.radius, "above 0, 1e-18..1e18");
    if (d.order == COHSM_ORDER_DEFAULT) d.order = COHSM_ORDER_HILBERT;
    if (d.orientation == COHSM_ORIENTATION_DEFAULT) d.orientation = COHSM_ORIENTATION_POLAR;
    memset(&heap, 0, sizeof heap);
    heap.allocator = cohsm__allocator_of(&d.system);
    return cohsm__log_build(&log, &d, cohsm__builder_make(&d, &heap, out));
}

COHSM_DEF uint32_t cohsm_builder_view_count(const cohsm_builder *b) { return b ? b->head.view_count : 0; }

static void cohsm__put_row(float *m, int row, cohsm__v3 v, float w)
{
    m[row] = v.x;
    m[row + 4] = v.y;
    m[row + 8] = v.z;
    m[row + 12] = w;
}

static void cohsm__view_matrix(const cohsm__header *h, const cohsm__camera *cam, cohsm__v3 location, float *m)
{
    float half = 0.5f * (float)h->map_side, scale = half / h->radius;
    cohsm__v3 c = cohsm__v3_load(h->center);
    cohsm__v3 axis[3], x, y, w;
    int i = (int)(cam->face >> 1);

    memset(m, 0, 16 * sizeof *m);
    m[15] = 1.0f;
    if (!cam->perspective) {
        cohsm__put_row(m, 0, cohsm__v3_scale(cam->axes.right, scale),
                       half - scale * cohsm__v3_dot(cam->axes.right, c));
        cohsm__put_row(m, 1, cohsm__v3_scale(cam->axes.up, scale),
                       half - scale * cohsm__v3_dot(cam->axes.up, c));
        cohsm__put_row(m, 2, cohsm__v3_scale(cam->axes.back, -0.5f / h->radius),
                       0.5f + 0.5f / h->radius * cohsm__v3_dot(cam->axes.back, c));
        return;
    }
    axis[0] = cohsm__v3_make(1, 0, 0);
    axis[1] = cohsm__v3_make(0, 1, 0);
    axis[2] = cohsm__v3_make(0, 0, 1);
    w = cohsm__v3_scale(axis[i], cam->face & 1u ? -1.0f : 1.0f);
    x = cohsm__v3_scale(cohsm__v3_add(axis[(i + 1) % 3], w), half);
    y = cohsm__v3_scale(cohsm__v3_add(axis[(i + 2) % 3], w), half);
    cohsm__put_row(m, 0, x, -cohsm__v3_dot(x, location));
    cohsm__put_row(m, 1, y, -cohsm__v3_dot(y, location));
    cohsm__put_row(m, 3, w, -cohsm__v3_dot(w, location));
}

COHSM_DEF cohsm_result cohsm_builder_view(const cohsm_builder *b, uint32_t index, cohsm_view *out)
{
    cohsm__camera cam;
    cohsm__v3 location;
    uint32_t cell;
    cohsm__logger log;

    if (!b) return COHSM_ERR_ARGUMENT;
    log = cohsm__logger_of(&b->desc.system, "cohsm_builder_view");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (index >= b->head.view_count) {
        cohsm__log_bound(&log, "index", index, "below", b->head.view_count, "the number of views");
        return COHSM_ERR_ARGUMENT;
    }
    memset(out, 0, sizeof *out);
    cell = b->cells[index % b->head.map_count];
    location = cohsm__cell_location(&b->head, b->locations, cell);
    out->index = index;
    out->cell = cell;
    out->face = index / b->head.map_count;
    cohsm__v3_store(out->location, location);
    out->location[3] = b->head.positional ? 1.0f : 0.0f;
    cam = cohsm__camera_of(&b->head, b->locations, b->angles, cell, out->face);
    if (cam.perspective) out->depth_scale = 1.0f / b->head.depth_far;
    cohsm__view_matrix(&b->head, &cam, location, out->matrix);
    return COHSM_OK;
}

static cohsm_result cohsm__close_batch(cohsm_builder *b)
{
    cohsm_result result = cohsm__compress_batch(b);
    b->next_view = b->batch_begin + b->batch_count;
    b->batch_begin = b->next_view;
    b->batch_count = 0;
    if (result == COHSM_OK && (b->next_view % COHSM__CHUNK == 0 || b->next_view == b->head.view_count))
        result = cohsm__close_chunk(b);
    b->finished = result != COHSM_OK;
    return result;
}

/* Turns the caller's depths into 16-bit layers of the shard's pixels. */
static void cohsm__take_layers(const cohsm_builder *b, uint16_t *z, const float *z1, const float *z2,
                               const float *z3)
{
    const float *layer[3];
    cohsm__camera cam =
        cohsm__camera_of(&b->head, b->locations, b->angles, b->cells[b->next_view % b->head.map_count],
                         b->next_view / b->head.map_count);
    uint32_t p, pixel, i;

    layer[0] = z1;
    layer[1] = z2;
    layer[2] = z3;
    for (p = 0; p < b->range_pixels; p++) {
        pixel = b->desc.pixel_begin + p;
        for (i = 0; i < (b->keep == 4 ? 3u : 2u); i++)
            z[pixel * b->keep + i] =
                layer[i][pixel] <= 1.0f ? cohsm__depth16(layer[i][pixel]) : (uint16_t)COHSM__INFINITE;
        if (b->keep == 4) z[pixel * b->keep + 3] = cohsm__leave_depth(&cam, b->head.map_side, pixel);
    }
}

COHSM_DEF cohsm_result cohsm_builder_add(cohsm_builder *b, uint32_t index, const float *z1, const float *z2,
                                         const float *z3)
{
    uint32_t i, pixels;
    cohsm__logger log;

    if (!b) return COHSM_ERR_ARGUMENT;
    log = cohsm__logger_of(&b->desc.system, "cohsm_builder_add");
    if (!z1) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "z1", "is NULL");
    if (!z2) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "z2", "is NULL");
    if (b->keep == 4 && !z3) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "z3", "is NULL");
    if (b->finished)
        return cohsm__refuse(&log, COHSM_ERR_ORDER, "the builder", "has ended, or failed before");
    if (index >= b->head.view_count) {
        cohsm__log_bound(&log, "index", index, "below", b->head.view_count, "the number of views");
        return COHSM_ERR_ORDER;
    }
    if (index != b->batch_begin + b->batch_count) {
        cohsm__log_value(&log, "index", (double)index, "the number of views that were added before");
        return COHSM_ERR_ORDER;
    }
    pixels = b->head.map_side * b->head.map_side;
    for (i = 0; i < pixels; i++)
        if (!(z1[i] <= z2[i]) || (b->keep == 4 && !(z2[i] <= z3[i]))) {
            cohsm__log_element(&log, z1[i] <= z2[i] ? "z2" : "z1", i, "is",
                               (double)(z1[i] <= z2[i] ? z2[i] : z1[i]),
                               "at most the depth of the next layer there");
            return COHSM_ERR_INPUT;
        }
    b->next_view = index;
    cohsm__take_layers(b, b->batch + (size_t)b->batch_size * b->batch_count, z1, z2, z3);
    b->batch_count++;
    if (b->batch_count < b->batch_views && index + 1 < b->head.view_count) return COHSM_OK;
    return cohsm__log_result(&log, cohsm__close_batch(b));
}
