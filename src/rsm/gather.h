/* ---- gather: bounced light of receivers (equations 1 and 2) ---- */

/* Writes or adds the result of receiver `at`, times the share that is open there. */
static inline void rsm__write_sum(const rsm__gather *g, size_t at, const float rgb[3])
{
    const rsm_points *p = g->points;
    float open = 1.0f, *out = g->out + 3 * at;
    int c;
    if (p->open) open = *rsm__element_at(p->open, rsm__stride_or(p->open_stride, 4), at);
    open = open > 0.0f ? open < 1.0f ? open : 1.0f : 0.0f;
    for (c = 0; c < 3; c++) out[c] = (g->desc.add ? out[c] : 0.0f) + rgb[c] * g->scale * open;
}

/* Gathers for one receiver, the number-th of those asked for. With wants_share it also finds the share of
   flux that lies beyond r_max. */
static inline void rsm__gather_one(const rsm__gather *g, size_t number, rsm__tally *tally, int wants_share)
{
    const rsm_points *p = g->points;
    size_t at = p->indices ? p->indices[number] : number, i, px = p->width ? at % p->width : at;
    size_t py = p->width ? at / p->width : 0;
    uint32_t k = g->desc.interleave, set = (uint32_t)(px % k + k * (py % k));
    float x[7], noise = 0.0f, *out = g->out + 3 * at;
    rsm__sum sum = { { 0, 0, 0 }, 0, 0, 0 };
    rsm__v3 position, normal;
    int c;
    if (!rsm__load_receiver(p, at, &position, &normal, &tally->bad)) {
        for (c = 0; c < 3 && !g->desc.add; c++) out[c] = 0.0f;
        return;
    }
    if (g->desc.noise)
        noise = g->desc.noise[py % g->desc.noise_side * g->desc.noise_side + px % g->desc.noise_side];
    rsm__v3_store(x, position);
    rsm__v3_store(x + 3, normal);
    x[6] = rsm__rounding(x[0], x[1], x[2]);
    for (i = 0; i < g->source_count; i++) {
        const rsm__source *s = g->sources + i;
        if (s->blocks) rsm__gather_shared(g, s, x, set, &sum);
        if (s->map && g->pattern) rsm__gather_centred(g, s->map, x, set, noise, &sum);
        if (s->map && g->pattern && wants_share && g->desc.r_max > 0.0f) {
            tally->outside += rsm__outside_share(s->map, g->desc.r_max, position);
            tally->looked += 1.0;
        }
        tally->pairs += (s->blocks ? s->set_lanes : 0) + g->set_samples;
    }
    if (g->reach2) g->reach2[at] = 1.0f / (sum.nearby > 1e-30f ? sum.nearby : 1e-30f);
    tally->evaluated++;
    tally->full += (double)sum.full;
    tally->lost += (double)sum.lost;
    rsm__write_sum(g, at, sum.rgb);
}

/* Gathers for a batch of receivers. */
static inline void rsm__gather_batch(void *context, size_t batch)
{
    const rsm__gather *g = (const rsm__gather *)context;
    rsm__tally *tally = g->tallies + batch;
    size_t i, first = batch * RSM__BATCH, end = first + RSM__BATCH < g->count ? first + RSM__BATCH : g->count;
    size_t every = g->count / 64 + 1;
    memset(tally, 0, sizeof *tally);
    for (i = first; i < end; i++) rsm__gather_one(g, i, tally, i % every == 0);
}

/* Returns whether the pixels of a row that take the same set are gathered for together, as many as a vector
   has lanes. So it is for interleaved pictures with few lights a set. */
static inline int rsm__gathers_by_rows(const rsm__gather *g)
{
    size_t i;
    if (g->desc.visible_fn) return 0;
    if (g->sets == 1 || g->pattern || g->desc.materials || g->points->width == 0 || g->points->indices)
        return 0;
    for (i = 0; i < g->source_count; i++) /* sums of more lights would lose bits; more lights fill the lanes
                                             anyway */
        if (g->sources[i].reaches || g->sources[i].set_lanes > RSM__FEW) return 0;
    return 1;
}

/* Puts receiver `at` into the next lane; a receiver that is none gets its result at once. */
static inline void rsm__receiver_lanes_add(const rsm__gather *g, rsm__receiver_lanes *p, size_t at,
                                           rsm__tally *tally)
{
    rsm__v3 position, normal;
    float x[6];
    int c;
    if (!rsm__load_receiver(g->points, at, &position, &normal, &tally->bad)) {
        for (c = 0; c < 3 && !g->desc.add; c++) g->out[3 * at + (size_t)c] = 0.0f;
        return;
    }
    rsm__v3_store(x, position);
    rsm__v3_store(x + 3, normal);
    for (c = 0; c < 6; c++) p->x[c][p->count] = x[c];
    p->x[6][p->count] = rsm__rounding(x[0], x[1], x[2]);
    p->at[p->count++] = at;
}

/* Gathers from one set for all lanes that are filled, writes their results and empties the lanes. */
static inline void rsm__gather_receiver_lanes(const rsm__gather *g, rsm__receiver_lanes *p, uint32_t set,
                                              rsm__tally *tally)
{
    size_t i, l;
    float rgb[3];
    int c;
    for (i = 0; i < g->source_count && p->count; i++) {
        const rsm__source *s = g->sources + i;
        if (s->blocks) g->lanes_kernel(s->blocks + set * s->set_blocks, s->set_lights, p);
        tally->pairs += (s->blocks ? s->set_lanes : 0) * p->count;
    }
    for (l = 0; l < p->count; l++) {
        for (c = 0; c < 3; c++) rgb[c] = p->sums[c][l];
        rsm__write_sum(g, p->at[l], rgb);
        tally->evaluated++;
        tally->full += (double)p->sums[3][l];
        tally->lost += (double)p->sums[4][l];
    }
    memset(p, 0, sizeof *p);
}

/* Gathers for a row of a picture, set by set. */
static inline void rsm__gather_row(void *context, size_t y)
{
    const rsm__gather *g = (const rsm__gather *)context;
    rsm__tally *tally = g->tallies + y;
    size_t width = g->points->width, first = y * width,
           n = g->count - first < width ? g->count - first : width, x;
    uint32_t k = g->desc.interleave, column;
    rsm__receiver_lanes p;
    memset(tally, 0, sizeof *tally);
    memset(&p, 0, sizeof p);
    for (column = 0; column < k; column++) {
        uint32_t set = column + k * (uint32_t)(y % k);
        for (x = column; x < n; x += k) {
            rsm__receiver_lanes_add(g, &p, first + x, tally);
            if (p.count == g->receiver_lane_count) rsm__gather_receiver_lanes(g, &p, set, tally);
        }
        rsm__gather_receiver_lanes(g, &p, set, tally);
    }
}

static inline rsm_result rsm__materials_check(const rsm__logger *log, const rsm_gather_desc *d)
{
    uint32_t i;
    int c;
    if (!d->materials && d->material_count)
        return rsm__refuse(log, RSM_ERR_DESC, "desc.materials", "is NULL, and material_count is not 0");
    for (i = 0; i < d->material_count; i++) {
        const rsm_material *m = d->materials + i;
        if (!(m->exponent >= 0.0f && m->exponent <= 1e4f)) {
            rsm__log_element(log, "desc.materials", i, "has the exponent", (double)m->exponent, "0..1e4");
            return RSM_ERR_INPUT;
        }
        for (c = 0; c < 3; c++) {
            if (m->specular[c] >= 0.0f && m->specular[c] <= 1.0f) continue;
            rsm__log_element(log, "desc.materials", i, "has the specular", (double)m->specular[c], "0..1");
            return RSM_ERR_INPUT;
        }
    }
    return RSM_OK;
}

static inline rsm_result rsm__noise_check(const rsm__logger *log, const rsm_gather_desc *d)
{
    uint32_t i;
    if (!d->noise) return RSM_OK;
    if (!rsm__check_range(log, "desc.noise_side", d->noise_side, 1, 4096, "1..4096")) return RSM_ERR_DESC;
    for (i = 0; i < d->noise_side * d->noise_side; i++)
        if (!(d->noise[i] >= 0.0f && d->noise[i] <= 1.0f)) {
            rsm__log_element(log, "desc.noise", i, "is", (double)d->noise[i], "0..1");
            return RSM_ERR_INPUT;
        }
    return RSM_OK;
}

static inline rsm_result rsm__numbers_check(const rsm__logger *log, const rsm_gather_desc *d)
{
    const rsm_result bad = RSM_ERR_DESC;
    const int poisson = d->pattern == RSM_PATTERN_POISSON;
    if (!rsm__check_range(log, "desc.pattern", (double)d->pattern, 0, RSM_PATTERN_COUNT - 1,
                          "one of rsm_pattern"))
        return bad;
    if (!rsm__check_range(log, "desc.sample_count", d->sample_count, 0,
                          poisson ? RSM__MAX_POISSON : RSM__MAX_SAMPLES,
                     poisson ? "0..4096 with POISSON" : "0..2^20"))
        return bad;
    if (!rsm__check_range(log, "desc.r_max", (double)d->r_max, 0, 1e3, "0..1000")) return bad;
    if (!rsm__check_range(log, "desc.r_min", (double)d->r_min, 0, 0.99999994, "0 or more, below 1"))
        return bad;
    if (!rsm__check_range(log, "desc.offset", (double)d->offset, 0, 1e9, "0..1e9")) return bad;
    if (!rsm__check_range(log, "desc.clamp", (double)d->clamp, 0, (double)1e18f, "0..1e18")) return bad;
    if (!rsm__check_range(log, "desc.near_limit", (double)d->near_limit, 0, 1e6, "0..1e6")) return bad;
    if (!rsm__check_range(log, "desc.near_field", (double)d->near_field, 0, 32, "0..32")) return bad;
    if (d->interleave <= 8 && (d->interleave & (d->interleave - 1)) == 0) return RSM_OK;
    rsm__log_value(log, "desc.interleave", d->interleave, "0, 1, 2, 4 or 8");
    return bad;
}

/* Checks that lights have numbers where visible_fn wants them: those about each receiver have none. */
static inline rsm_result rsm__seeing_check(const rsm__logger *log, const rsm_gather_desc *d)
{
    if (!d->visible_fn || d->sample_count == 0 || d->pattern == RSM_PATTERN_FLUX) return RSM_OK;
    rsm__log_value(log, "desc.pattern", (double)d->pattern,
                   "RSM_PATTERN_FLUX with visible_fn, unless sample_count is 0");
    return RSM_ERR_DESC;
}

/* Checks a desc, which may be NULL, and writes it with its defaults to out. */
static inline rsm_result rsm__gather_check(const rsm__logger *log, const rsm_gather_desc *desc,
                                           const rsm_points *points, rsm_gather_desc *out)
{
    rsm_result result;
    memset(out, 0, sizeof *out);
    if (desc) *out = *desc;
    result = rsm__numbers_check(log, out);
    if (result == RSM_OK) result = rsm__noise_check(log, out);
    if (result == RSM_OK) result = rsm__materials_check(log, out);
    if (result != RSM_OK) return result;
    if (!rsm__system_valid(log, &out->system)) return RSM_ERR_DESC;
    if (out->pattern == RSM_PATTERN_DEFAULT) out->pattern = RSM_PATTERN_FLUX;
    if (!(out->r_min > 0.0f)) out->r_min = 1.0f / 32.0f;
    if (out->pattern == RSM_PATTERN_MIXED) {
        out->r_min = RSM__MIXED_MIN;
        out->r_max = 0.0f;
    }
    if (out->interleave == 0) out->interleave = 1;
    if (out->interleave == 1 || points->width != 0) return RSM_OK;
    rsm__log_value(log, "desc.interleave", out->interleave,
                   "0 or 1 if points.width is 0: one row is no picture");
    return RSM_ERR_DESC;
}

/* Gives back what rsm__gather_open and rsm__make_tallies allocated. */
static inline void rsm__gather_close(rsm__gather *g, const rsm__allocator *a)
{
    size_t i = g->sources ? g->source_count : 0;
    rsm__free(a, g->tallies);
    rsm__free(a, g->pattern);
    while (i-- > 0) {
        rsm__free(a, g->sources[i].reaches);
        rsm__free(a, g->sources[i].numbers);
        rsm__free(a, g->sources[i].gloss);
        rsm__free(a, g->sources[i].blocks);
    }
    rsm__free(a, g->sources);
}

/* Makes what all receivers share: sources, sets, the pattern. If it fails, the caller calls
   rsm__gather_close. */
static inline rsm_result rsm__gather_open(rsm__gather *g, const rsm_map *const *maps, size_t map_count,
                                          const rsm_texel *lights, size_t light_count,
                                          const rsm__allocator *a)
{
    size_t i;
    int list = maps == NULL, mixed = g->desc.pattern == RSM_PATTERN_MIXED && g->desc.sample_count > 1;
    rsm_result result = RSM_OK;
    g->source_count = list ? 1 : map_count;
    g->sets = g->desc.interleave * g->desc.interleave;
    g->scale = 1.0f / RSM__PI;
    g->shared = g->centred = g->set_samples = 0;
    if (!list && g->desc.sample_count) {
        g->centred = mixed ? 3u * g->desc.sample_count / 5u : g->desc.sample_count;
        if (g->desc.pattern == RSM_PATTERN_FLUX || (g->desc.pattern == RSM_PATTERN_MIXED && !mixed))
            g->centred = 0;
        g->shared = g->desc.sample_count - g->centred;
    }
    g->sources = (rsm__source *)rsm__alloc_array(a, g->source_count, sizeof *g->sources);
    if (!g->sources) return RSM_ERR_ALLOC;
    memset(g->sources, 0, g->source_count * sizeof *g->sources);
    if (g->centred) {
        uint32_t n, k;
        float *sorted;
        g->set_samples = (g->centred + g->sets - 1) / g->sets;
        n = g->set_samples * g->sets; /* rounded up to sets of the same size, so that every sample weighs the
                                         same; RSM__MAX_POISSON is a multiple of any number of sets */
        g->pattern = (float *)rsm__alloc_array(a, n, 3 * sizeof *g->pattern);
        sorted = (float *)rsm__alloc_array(a, n, 3 * sizeof *sorted);
        if (!g->pattern || !sorted) {
            rsm__free(a, sorted);
            return RSM_ERR_ALLOC;
        }
        g->centred = n;
        rsm__pattern_make(mixed ? RSM_PATTERN_LOG_RADIAL : g->desc.pattern, n, g->desc.r_min,
                          g->desc.paper_weights, g->desc.seed, sorted);
        for (k = 0; k < n; k++) { /* sample k goes to set k % sets */
            float *to = g->pattern + 3 * ((size_t)(k % g->sets) * g->set_samples + k / g->sets);
            memcpy(to, sorted + 3 * (size_t)k, 3 * sizeof *to);
        }
        rsm__free(a, sorted);
    }
    for (i = 0; i < g->source_count && result == RSM_OK; i++) {
        if (!list) g->sources[i].map = maps[i];
        if (list) result = rsm__pack_list(g, g->sources, lights, light_count, a);
        else if (g->shared || !g->desc.sample_count) result = rsm__pack_map(g, g->sources + i, a);
    }
    return result;
}

/* Adds the tallies of all tasks to the statistics. sums collects what shares are made of. */
static inline void rsm__gather_add_stats(const rsm__gather *g, size_t batches, rsm_gather_stats *stats,
                                         double sums[4])
{
    size_t i;
    for (i = 0; i < batches; i++) {
        stats->evaluated += g->tallies[i].evaluated;
        stats->pairs += g->tallies[i].pairs;
        stats->bad_points += g->tallies[i].bad;
        sums[0] += g->tallies[i].full;
        sums[1] += g->tallies[i].lost;
        sums[2] += g->tallies[i].outside;
        sums[3] += g->tallies[i].looked;
    }
    stats->clamped_share = sums[0] > 0.0 ? sums[1] / sums[0] : 0.0;
    stats->outside_share = sums[3] > 0.0 ? sums[2] / sums[3] : 0.0;
}

static inline rsm_result rsm__maps_check(const rsm__logger *log, const rsm_map *const *maps, size_t map_count)
{
    size_t i;
    if (!maps) return rsm__refuse(log, RSM_ERR_ARGUMENT, "maps", "is NULL");
    if (map_count == 0) return rsm__refuse(log, RSM_ERR_ARGUMENT, "map_count", "is 0");
    for (i = 0; i < map_count; i++) {
        if (maps[i]) continue;
        rsm__log_element_text(log, "maps", i, "is NULL");
        return RSM_ERR_ARGUMENT;
    }
    for (i = 0; i < map_count; i++) {
        if (maps[i]->finished) continue;
        rsm__log_element_text(log, "maps", i, "is not finished: rsm_finish must come first");
        return RSM_ERR_ORDER;
    }
    return RSM_OK;
}

/* Logs why a gather failed after its arguments were checked, and returns the result. */
static inline rsm_result rsm__gather_logged(const rsm__logger *log, rsm_result result)
{
    if (result == RSM_ERR_ALLOC)
        rsm__log_text(log, "the allocator", "returned no memory for lights or receivers");
    if (result == RSM_ERR_CANCELLED) rsm__log_text(log, "progress", "cancelled the call");
    return result;
}

/* Returns how many tasks gather for so many receivers: rows of a picture, or batches. */
static inline size_t rsm__count_tasks(const rsm__gather *g, size_t count)
{
    size_t each = rsm__gathers_by_rows(g) ? g->points->width : (size_t)RSM__BATCH;
    return count / each + (count % each != 0);
}

/* Takes memory for the tallies of all tasks of an opened gather. If it fails, the caller calls
   rsm__gather_close. */
static inline rsm_result rsm__make_tallies(rsm__gather *g, const rsm__allocator *a)
{
    size_t batches = rsm__count_tasks(g, g->points->indices ? g->points->index_count : g->points->count);
    g->tallies = (rsm__tally *)rsm__alloc_array(a, batches + 1, sizeof *g->tallies);
    return g->tallies ? RSM_OK : RSM_ERR_ALLOC;
}

/* Gathers for the receivers of g->points. begin and end are the fractions of the whole call at which this
   part begins and ends. */
static inline rsm_result rsm__gather_points(rsm__gather *g, rsm_gather_stats *stats, float begin, float end)
{
    size_t batches;
    rsm_gather_stats s;
    double sums[4] = { 0, 0, 0, 0 };
    g->count = g->points->indices ? g->points->index_count : g->points->count;
    batches = rsm__count_tasks(g, g->count);
    if (!rsm__run_steps(&g->desc.system, batches,
                        rsm__gathers_by_rows(g) ? rsm__gather_row : rsm__gather_batch, g, begin, end))
        return RSM_ERR_CANCELLED;
    if (!stats) return RSM_OK;
    memset(&s, 0, sizeof s);
    rsm__gather_add_stats(g, batches, &s, sums);
    *stats = s;
    return RSM_OK;
}

/* Returns whether the light that bounds take off has to be summed. */
static inline int rsm__loss_wanted(const rsm__gather *g, const rsm_gather_stats *stats)
{
    return stats && (g->desc.clamp > 0.0f || g->desc.near_limit > 0.0f);
}

static inline rsm_result rsm__gather_run(rsm__gather *g, const rsm_map *const *maps, size_t map_count,
                                         const rsm_texel *lights, size_t light_count, rsm_gather_stats *stats)
{
    rsm__allocator a = rsm__allocator_of(&g->desc.system);
    rsm_result result;
    g->kernel = rsm__choose_kernel(rsm__loss_wanted(g, stats), 0);
    g->lanes_kernel = rsm__choose_receiver_lanes_kernel(rsm__loss_wanted(g, stats), &g->receiver_lane_count);
    result = rsm__gather_open(g, maps, map_count, lights, light_count, &a);
    if (result == RSM_OK) result = rsm__make_tallies(g, &a);
    if (result == RSM_OK) result = rsm__gather_points(g, stats, 0.0f, 1.0f);
    rsm__gather_close(g, &a);
    return result;
}

RSM_DEF rsm_result rsm_gather(const rsm_map *const *maps, size_t map_count, const rsm_gather_desc *desc,
                              const rsm_points *points, float *irradiance, rsm_gather_stats *stats)
{
    const rsm_map *first = maps && map_count ? maps[0] : NULL;
    rsm__logger log = rsm__logger_of_map(desc ? &desc->system : NULL, first, "rsm_gather");
    rsm__gather g;
    rsm_result result = rsm__maps_check(&log, maps, map_count);
    memset(&g, 0, sizeof g);
    if (result == RSM_OK) result = rsm__points_check(&log, points, irradiance);
    if (result == RSM_OK) result = rsm__gather_check(&log, desc, points, &g.desc);
    if (result == RSM_OK) result = rsm__seeing_check(&log, &g.desc);
    if (result != RSM_OK) return result;
    g.points = points;
    g.out = irradiance;
    return rsm__gather_logged(&log, rsm__gather_run(&g, maps, map_count, NULL, 0, stats));
}

/* Checks a list of pixel lights. */
static inline rsm_result rsm__lights_check(const rsm__logger *log, const rsm_texel *lights, size_t count)
{
    size_t i;
    if (!lights && count) return rsm__refuse(log, RSM_ERR_ARGUMENT, "lights", "is NULL");
    for (i = 0; i < count; i++)
        if (!rsm__unit_or_none(lights[i].normal))
            return rsm__refuse_normal(log, "lights.normal", i, rsm__v3_load(lights[i].normal));
    return RSM_OK;
}

RSM_DEF rsm_result rsm_gather_list(const rsm_texel *lights, size_t count, const rsm_gather_desc *desc,
                                   const rsm_points *points, float *irradiance, rsm_gather_stats *stats)
{
    rsm__logger log = rsm__logger_of(desc ? &desc->system : NULL, "rsm_gather_list");
    rsm__gather g;
    rsm_result result = rsm__lights_check(&log, lights, count);
    memset(&g, 0, sizeof g);
    if (result == RSM_OK) result = rsm__points_check(&log, points, irradiance);
    if (result == RSM_OK) result = rsm__gather_check(&log, desc, points, &g.desc);
    if (result != RSM_OK) return result;
    g.desc.materials = NULL;
    g.desc.noise = NULL;
    g.points = points;
    g.out = irradiance;
    return rsm__gather_logged(&log, rsm__gather_run(&g, NULL, 0, lights, count, stats));
}
