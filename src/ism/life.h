/* ---- life: create, free, a frame in one call ---- */

ISM_DEF const char *ism_result_text(ism_result result)
{
    static const char *const texts[] = {
#define ISM__TEXT(name, text) text,
        ISM_RESULTS(ISM__TEXT)
#undef ISM__TEXT
    };
    return (int)result >= 0 && (int)result < (int)ISM_RESULT_COUNT ? texts[result] : "unknown result";
}

/* A field of ism_desc and the range in which it must lie, else the call returns ISM_ERR_DESC. Zero always
   passes. */
typedef struct ism__range { const char *name; double value, least, most; const char *wanted; } ism__range;

static int ism__power_of_two(uint32_t x) { return (x & (x - 1u)) == 0; }

static ism_result ism__check_desc(const ism__logger *log, const ism_desc *d)
{
    double side = d->tile_side ? (double)d->tile_side : 64.0;
    const ism__range ranges[] = {
        { "desc.vpl_count", (double)d->vpl_count, 1, 16384, "0 or 1..16384" },
        { "desc.surfel_count", (double)d->surfel_count, 8, 65536, "0 or 8..65536" },
        { "desc.tile_side", ism__power_of_two(d->tile_side) ? side : -1, 8, 256,
          "0 or a power of two, 8..256" },
        { "desc.importance", (double)d->importance, 0, ISM_IMPORTANCE_COUNT - 1,
          "a value of ism_importance" },
#ifdef ISM_WITHOUT_PAIR
        { "desc.spread", (double)d->spread, 0, ISM_SPREAD_VIEW_8,
          "below ISM_SPREAD_PAIR in a header that was joined without pair" },
#else
        { "desc.spread", (double)d->spread, 0, ISM_SPREAD_COUNT - 1, "a value of ism_spread" },
#endif
        { "desc.projection", (double)d->projection, 0, ISM_PROJECTION_COUNT - 1,
          "a value of ism_projection" },
        { "desc.view_grid_side", (double)d->view_grid_side, 1, 16, "0 or 1..16" },
        { "desc.blur_radius", (double)d->blur_radius, -2147483648.0, 16, "16 at most" },
        { "desc.lazy_frames", (double)d->lazy_frames, 1, 64, "0 or 1..64" },
        { "desc.flux_share", (double)d->flux_share, 0, 1, "0..1" },
        { "desc.area_share", (double)d->area_share, 0, 1, "0..1" },
        { "desc.splat_scale", (double)d->splat_scale, 0, 16, "0..16" },
#ifdef ISM_WITHOUT_NEAR_POINTS
        { "desc.near_point_count", (double)d->near_point_count, -2147483648.0, 0,
          "0 or less in a header that was joined without near points" },
#else
        { "desc.near_point_count", (double)d->near_point_count, -2147483648.0, 64, "64 at most" },
#endif
#ifdef ISM_WITHOUT_WINDOWS
        { "desc.window_rim", (double)d->window_rim, -2147483648.0, 0,
          "0 or less in a header that was joined without windows" }
#else
        { "desc.window_rim", d->window_rim < 0 ? 0.0 : (double)d->window_rim, 2, 0.5 * side,
          "negative, 0 or 2..tile_side / 2" }
#endif
    };
    size_t i;
    for (i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        const ism__range *r = &ranges[i];
        if (r->value >= r->least && r->value <= r->most) continue;
        if (r->value >= 0.0 && r->value <= 0.0) continue;
        return ism__bad_field(log, r->name, i == 2u ? (double)d->tile_side : r->value, r->wanted);
    }
    if (ism__allocator_valid(d->system.allocator.alloc_fn, d->system.allocator.free_fn)) return ISM_OK;
    ism__log_text(log, "desc.system.allocator", "has one function of two");
    return ISM_ERR_DESC;
}

/* Puts defaults in place of zeros, and 0 in place of negative numbers, which mean none. */
static void ism__resolve(ism_desc *d)
{
    if (!d->vpl_count) d->vpl_count = 1024u;
    if (!d->surfel_count) d->surfel_count = 8192u;
    if (!d->tile_side) d->tile_side = 64u;
    if (d->importance == ISM_IMPORTANCE_DEFAULT) d->importance = ISM_IMPORTANCE_GUIDED;
#ifdef ISM_WITHOUT_PAIR
    if (d->spread == ISM_SPREAD_DEFAULT) d->spread = ISM_SPREAD_VIEW_8;
#else
    if (d->spread == ISM_SPREAD_DEFAULT) d->spread = ISM_SPREAD_PAIR;
#endif
    if (d->projection == ISM_PROJECTION_DEFAULT) d->projection = ISM_PROJECTION_COSINE;
    if (!d->view_grid_side) d->view_grid_side = 4u;
    if (!d->lazy_frames) d->lazy_frames = 8u;
#ifndef ISM_WITHOUT_NEAR_POINTS
    if (!d->near_point_count) d->near_point_count = 16;
#endif
#ifndef ISM_WITHOUT_WINDOWS
    if (!d->window_rim) d->window_rim = d->tile_side >= 16u ? (int32_t)(d->tile_side / 8u) : 2;
#endif
    if (d->near_point_count < 0) d->near_point_count = 0;
    if (d->window_rim < 0) d->window_rim = 0;
    if (!(d->flux_share > 0.0f)) d->flux_share = 0.1f;
    if (!(d->area_share > 0.0f)) d->area_share = 0.2f;
    if (!(d->splat_scale > 0.0f)) d->splat_scale = 0.8f;
}

ISM_DEF ism_result ism_create(const ism_desc *desc, ism_maps **out)
{
    ism__allocator memory;
    ism_desc d;
    ism_maps *m;
    ism__tile tile;
    ism_vpl none;
    ism__job job;
    size_t texels;
    ism_result result;
    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    ism__begin_job(&d.system, "ism_create", NULL, &job);
    if (!out) return ism__is_null(&job.log, "out");
    result = ism__check_desc(&job.log, &d);
    if (result != ISM_OK) return result;
    ism__resolve(&d);
    memory =
        ism__allocator_make(d.system.allocator.alloc_fn, d.system.allocator.free_fn, d.system.allocator.user);
    m = (ism_maps *)ism__alloc(&memory, sizeof *m);
    if (!m) return ism__no_memory(&job.log);
    memset(m, 0, sizeof *m);
    m->desc = d;
    m->memory = memory;
    m->stats.bytes = m->stats.peak_bytes = sizeof *m + d.vpl_count * sizeof *m->vpls;
    for (m->tiles = 1; m->tiles * m->tiles < d.vpl_count; m->tiles++) {}
    m->side = m->tiles * d.tile_side;
    m->blank_from = m->tiles * m->tiles;
    texels = (size_t)d.tile_side * d.tile_side;
    m->vpls = (ism_vpl *)ism__alloc_array(&memory, d.vpl_count, sizeof *m->vpls);
    if (!m->vpls || !ism__grow(m, &m->previous, d.vpl_count, sizeof *m->vpls) ||
        !ism__grow(m, &m->directions, texels, 3u * sizeof(float))) {
        ism_free(m);
        return ism__no_memory(&job.log);
    }
    memset(&none, 0, sizeof none);
    memset(&tile, 0, sizeof tile);
    tile.vpl = &none;
    tile.size = d.tile_side;
    tile.projection = d.projection == ISM_PROJECTION_LOBE ? ISM_PROJECTION_COSINE : d.projection;
    ism__tile_directions(&tile, (float *)m->directions.data);
    *out = m;
    return ISM_OK;
}

ISM_DEF void ism_free(ism_maps *m)
{
    ism__allocator memory;
    if (!m) return;
    memory = m->memory;
    ism__release(m, &m->previous);
    ism__release(m, &m->atlas);
    ism__release(m, &m->hits);
    ism__release(m, &m->surfels);
    ism__release(m, &m->counts);
    ism__release(m, &m->directions);
    ism__release(m, &m->scratch);
    ism__release(m, &m->sums);
    ism__release(m, &m->clusters);
    ism__release(m, &m->shares);
    ism__release(m, &m->weights);
    ism__release(m, &m->sources);
    ism__release(m, &m->importance);
    ism__release(m, &m->blurred);
    ism__release(m, &m->cdf);
    ism__release(m, &m->pixels);
    ism__release(m, &m->near_points);
    ism__release(m, &m->near_blocks);
    ism__release(m, &m->near_drawn);
    ism__release(m, &m->near_keys);
    ism__release(m, &m->windows);
    ism__free(&memory, m->vpls);
    ism__free(&memory, m);
}

ISM_DEF void ism_get_info(const ism_maps *m, ism_info *out)
{
    if (!m || !out) return;
    out->vpl_count = m->vpl_count;
    out->near_point_count = m->near_count;
    out->surfel_count = m->desc.surfel_count;
    out->tile_side = m->desc.tile_side;
    out->lazy_frames = m->desc.lazy_frames;
    memcpy(out->center, m->center, sizeof m->center);
    out->radius = m->radius;
    out->stats = m->stats;
}

ISM_DEF ism_result ism_render(ism_maps *m, const ism_frame *frame, const ism_shading *shading, float *out,
                              ism_stats *stats)
{
    ism__job job, part;
    ism_shading none;
    ism_result result = ism__open_frame(m, frame, "ism_render", &job);
    if (result == ISM_OK && !out) result = ism__is_null(&job.log, "out");
    if (result != ISM_OK) return result;
    memset(&none, 0, sizeof none);
    if (!shading) shading = &none;
    part = job;
    part.part = ism__part_of(&job.part, 0.0f, 0.2f);
    result = ism__choose(m, &part);
    part.part = ism__part_of(&job.part, 0.2f, 0.5f);
    if (result == ISM_OK && !shading->no_maps && !shading->visible_fn) result = ism__build(m, &part);
    part.part = ism__part_of(&job.part, 0.5f, 1.0f);
    return result == ISM_OK ? ism__shade(m, &part, shading, out, stats) : result;
}
