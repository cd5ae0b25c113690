/* ---- verify: every stored value against its interval ---- */

typedef struct cohsm__check {
    const cohsm_builder *builder;       /* for layers and intervals; its batch holds the views */
    const cohsm_maps    *maps;
    cohsm_report         part[COHSM__RANGES];
} cohsm__check;

/* Returns the stored depth at a view, and writes the first view after its segment. */
static uint32_t cohsm__segment_depth(const cohsm_maps *m, uint32_t pixel, uint32_t view, uint32_t *end)
{
    uint32_t begin = view & ~(COHSM__CHUNK - 1u),
             entry = m->lookup[(size_t)(view >> COHSM__CHUNK_BITS) * m->range + pixel];
    uint32_t b = 0, count;
    uint32_t n, j, k;
    uint32_t at, bucket;
    const uint32_t *directory = m->directories + entry, *block;
    uint64_t marks;

    *end = cohsm__min_u32(m->head.view_count, begin + COHSM__CHUNK);
    if (entry & COHSM__CONSTANT) return entry & 0xffffu;
    count = cohsm__block_count(directory);
    while (b + 1 < count && cohsm__block_first(directory, b + 1u) <= view - begin) b++;
    if (b + 1 < count) *end = begin + cohsm__block_first(directory, b + 1u);
    if (b) begin += cohsm__block_first(directory, b);
    block = cohsm__block_at(directory, m->lines, b);
    marks = cohsm__marks(block);
    n = cohsm__popcount(marks);
    j = cohsm__block_find(block, view - begin);
    if (j + 1 < n) {                                /* the next mark, and its low bits */
        k = block[0] >> 8 & 15u;
        for (at = 0, count = 0; count <= j + 1u; at++) count += (uint32_t)(marks >> at & 1u);
        bucket = at - 1u - (j + 1u);
        *end = begin + (bucket << k | cohsm__bits(block, COHSM__LOW_AT + (j + 1u) * k, k));
    }
    return cohsm__block_depth(block, m->depth_of, n, j);
}

/* Compares a range of pixels in all views of the batch, pixel by pixel, so that a list is read once for many
   views. */
static void cohsm__verify_task(void *context, size_t index)
{
    cohsm__check *k = (cohsm__check *)context;
    const cohsm_builder *b = k->builder;
    cohsm_report *r = &k->part[index];
    uint32_t p, i, view, end;
    uint32_t lo, hi, z = 0;

    memset(r, 0, sizeof *r);
    for (p = b->ranges[index].begin; p < b->ranges[index].end; p++) {
        const uint16_t *layers = b->batch + (size_t)(b->desc.pixel_begin + p) * b->keep;
        for (i = 0, end = 0; i < b->batch_count; i++, layers += b->batch_size) {
            view = b->batch_begin + i;
            if (k->maps->trays.lines) z = cohsm__stored_depth(k->maps, p, view);
            else if (view >= end) z = cohsm__segment_depth(k->maps, p, view, &end);
            r->empty += (uint64_t)cohsm__interval(b, layers, &lo, &hi);
            r->entries++;
            if ((z >= lo && z <= hi) || (r->wrong++ && view >= r->first_view)) continue;
            r->first_view = view;
            r->first_pixel = p + b->desc.pixel_begin;
        }
    }
}

/* Returns the desc that a block was built with, with the caller's system. */
static cohsm_desc cohsm__desc_of(const cohsm_maps *m, const cohsm_system *system)
{
    const cohsm__header *h = &m->head;
    cohsm_desc d;

    memset(&d, 0, sizeof d);
    if (system) d.system = *system;
    d.domain.kind = (cohsm_domain_kind)h->domain;
    memcpy(d.domain.side, h->side, sizeof h->side);
    memcpy(d.domain.origin, h->origin, sizeof h->origin);
    memcpy(d.domain.u, h->u, sizeof h->u);
    memcpy(d.domain.v, h->v, sizeof h->v);
    memcpy(d.domain.w, h->w, sizeof h->w);
    if (h->location_words) {
        d.domain.locations = m->locations;
        d.domain.location_count = h->map_count;
    }
    d.map_side = h->map_side;
    d.layers = (cohsm_layers)h->layers;
    d.order = (cohsm_order)h->order;
    d.orientation = (cohsm_orientation)h->orientation;
    d.depth_bits = h->depth_bits;
    d.open_thickness = h->open_thickness;
    d.self_only = (int)h->self_only;
    memcpy(d.center, h->center, sizeof h->center);
    d.radius = h->radius;
    d.pixel_begin = h->pixel_begin;
    d.pixel_end = h->pixel_end;
    return d;
}

static cohsm_result cohsm__verify_views(cohsm_builder *b, const cohsm_maps *maps, const cohsm__soup *soup,
                                        cohsm_report *out)
{
    cohsm__job job;
    cohsm__check check;
    uint64_t wrong_before;
    uint32_t i;

    if (!cohsm__job_begin(&job, b, soup, NULL)) return COHSM_ERR_ALLOC;
    check.builder = b;
    check.maps = maps;
    for (; b->batch_begin < b->head.view_count; b->batch_begin += b->batch_count) {
        if (b->desc.system.progress &&
            b->desc.system.progress(b->desc.system.user, (float)b->batch_begin / (float)b->head.view_count)) {
            cohsm__job_end(&job);
            return COHSM_ERR_CANCELLED;
        }
        b->batch_count = cohsm__min_u32(b->batch_views, b->head.view_count - b->batch_begin);
        cohsm__draw_batch(&job);
        cohsm__run_tasks(&b->desc.system, COHSM__RANGES, cohsm__verify_task, &check);
        for (i = 0, wrong_before = out->wrong; i < COHSM__RANGES; i++) {
            const cohsm_report *r = &check.part[i];
            if (r->wrong && !wrong_before && (!out->wrong || r->first_view < out->first_view)) {
                out->first_view = r->first_view;
                out->first_pixel = r->first_pixel;
            }
            out->entries += r->entries;
            out->wrong += r->wrong;
            out->empty += r->empty;
        }
    }
    cohsm__job_end(&job);
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_verify(const cohsm_maps *maps, const cohsm_system *system,
                                    const cohsm_mesh *mesh, cohsm_report *out)
{
    cohsm_desc d;
    cohsm_stats stats;
    cohsm__counted_heap heap;
    cohsm__model model;
    cohsm_report report;
    cohsm_builder *b;
    cohsm__logger log = cohsm__logger_of(system, "cohsm_verify");
    cohsm_result result;

    if (!maps) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "maps", "is NULL");
    if (!mesh) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "mesh", "is NULL");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (system && !cohsm__system_valid(system))
        return cohsm__refuse(&log, COHSM_ERR_DESC, "system.allocator", "has one function of the two");
    d = cohsm__desc_of(maps, system);
    memset(&stats, 0, sizeof stats);
    memset(&heap, 0, sizeof heap);
    memset(&model, 0, sizeof model);
    memset(&report, 0, sizeof report);
    heap.allocator = cohsm__allocator_of(&d.system);
    result = cohsm__model_make(&model, &d, mesh, &heap, &stats, &log);
    if (result == COHSM_ERR_MISMATCH) cohsm__log_text(&log, "mesh", "reaches out of the sphere of the maps");
    if (result == COHSM_OK) {
        result = cohsm__builder_make(&d, &heap, &b);
        if (result == COHSM_OK) {
            result = cohsm__verify_views(b, maps, &model.soup, &report);
            cohsm__drop_builder(b, &heap);
        }
        (void)cohsm__log_build(&log, &d, result);
    }
    cohsm__soup_free(&model.soup, &heap);
    if (result == COHSM_OK) *out = report;
    return result;
}
