/* ---- build: a map becomes strata, and strata lights ---- */

/* Labels texels by the method. A cube with fewer lights than faces goes to the structured method, since the
   others give each face a light. */
static envlt_result envlt__label_texels(const envlt__grid *g, envlt_method method, uint32_t k,
                                        uint32_t *label, uint32_t *chosen, const envlt__allocator *a)
{
    if (method == ENVLT_METHOD_STRUCTURED || (g->faces == 6 && k < 6))
        return envlt__label_structured(g, k, label, a);
    return envlt__label_regions(g, method, k, label, chosen, a);
}

/* Gives label 0 to the sun, if desc.split_sun is set and there is a sun, and labels the other texels by the
   method. Writes how many labels there may be. */
static envlt_result envlt__label_with_sun(envlt_lights *l, const envlt__grid *g, uint32_t *label,
                                          uint32_t *chosen, uint32_t *labels)
{
    const envlt__allocator *a = &l->allocator;
    uint32_t k = l->desc.light_count, size = 0, i;
    uint32_t *queue = NULL;
    uint8_t *seen = NULL;
    float *kept = NULL;
    envlt_result result;
    size_t t;
    if (l->desc.split_sun) {
        queue = (uint32_t *)envlt__alloc_array(a, g->count, sizeof *queue);
        seen = queue ? (uint8_t *)envlt__alloc(a, g->count) : NULL;
        size = seen ? envlt__find_sun(g, k, queue, seen) : 0;
        kept = size ? (float *)envlt__alloc_array(a, size, sizeof *kept) : NULL;
    }
    if (l->desc.split_sun && (!seen || (size && !kept))) {
        result = ENVLT_ERR_ALLOC;
    } else {
        envlt__grid rest = *g;
        for (i = 0; i < size; i++) {
            kept[i] = g->lum[queue[i]];
            g->lum[queue[i]] = 0.0f;
        }
        /* The rest is summed anew. Beside a sun with 1e16 times the energy of the sky, the total less the sun
           would be nothing but rounding, and perhaps negative. */
        if (size) rest.total = envlt__sum_weights(g);
        result = envlt__label_texels(&rest, l->desc.method, size ? k - 1 : k, label, chosen + (size != 0), a);
        for (t = 0; size && t < g->count; t++) label[t] += label[t] != ENVLT_NO_LIGHT;
        for (i = 0; i < size; i++) {
            g->lum[queue[i]] = kept[i];
            label[queue[i]] = 0;
        }
        if (size) chosen[0] = ENVLT_NO_LIGHT;
        l->has_sun = size != 0;
        *labels = k + 6;
    }
    envlt__free(a, kept);
    envlt__free(a, seen);
    envlt__free(a, queue);
    return result;
}

/* Makes strata and lights of the grid. The labels are kept in the memory of the running sums, which are
   written last: to ask for fresh memory would cost as much time as to fill it with labels. */
static envlt_result envlt__build_lights(envlt_lights *l, const envlt__grid *g)
{
    const envlt__allocator *a = &l->allocator;
    uint32_t k = l->desc.light_count, labels = 0, i, *label = (uint32_t *)(void *)l->cdf;
    uint32_t *chosen = (uint32_t *)envlt__alloc_array(a, (size_t)k + 7, 2 * sizeof *chosen);
    envlt__sums *sums = chosen ? (envlt__sums *)envlt__alloc_array(a, (size_t)k + 7, sizeof *sums) : NULL;
    envlt_result result = ENVLT_ERR_ALLOC;
    size_t t;
    if (sums) {
        for (i = 0; i < k + 7; i++) chosen[i] = ENVLT_NO_LIGHT;
        for (t = 0; t < g->count; t++) label[t] = ENVLT_NO_LIGHT;
        result = g->total > 0.0 ? envlt__label_with_sun(l, g, label, chosen, &labels) : ENVLT_OK;
    }
    if (result == ENVLT_OK) {
        envlt__accumulate_sums(g, label, sums, labels);
        l->count = envlt__drop_dark(g, label, sums, chosen, chosen + k + 7, labels);
        if (l->desc.method != ENVLT_METHOD_CDF)
            for (i = 0; i < l->count; i++) chosen[i] = ENVLT_NO_LIGHT;
        memcpy(l->sums, sums, l->count * sizeof *sums);
        l->lit = l->count < k ? envlt__count_lit(g, l->has_sun ? label : NULL) + (l->has_sun ? 1 : 0) : 0;
        if (l->lit > k) l->lit = 0;         /* the method's rounding made lights fewer, not the map */
        envlt__sort_strata(l, g, label);
        envlt__fill_lights(l, g, chosen);
        envlt__fill_cdf(l, g);
        for (i = 0; i < l->count; i++) l->list[i].id = l->next_id++;
    }
    envlt__free(a, sums);
    envlt__free(a, chosen);
    return result;
}

/* Allocates through a meter, whose block begins with the size that was asked for. */
static void *envlt__meter_alloc(size_t size, void *user)
{
    envlt__meter *m = (envlt__meter *)user;
    char *block = size <= SIZE_MAX - 16 ? (char *)envlt__alloc(&m->inner, size + 16) : NULL;
    if (!block) return NULL;
    memcpy(block, &size, sizeof size);
    m->now += size + 16;
    if (m->now > m->peak) m->peak = m->now;
    return block + 16;
}

static void envlt__meter_free(void *memory, void *user)
{
    envlt__meter *m = (envlt__meter *)user;
    char *block = (char *)memory - 16;
    size_t size;
    memcpy(&size, block, sizeof size);
    m->now -= size + 16;
    envlt__free(&m->inner, block);
}

static void envlt__fill_stats(const envlt_lights *l, const envlt__grid *g, envlt_stats *stats)
{
    uint32_t i;
    int c;
    memset(stats, 0, sizeof *stats);
    stats->lights = l->count;
    stats->bad_texels = g->bad;
    stats->peak_bytes = l->meter.peak;
    for (i = 0; i < l->count; i++)
        for (c = 0; c < 3; c++) stats->energy[c] += l->sums[i].rgb[c];
}

static envlt_result envlt__check_desc(const envlt_desc *d, const envlt__logger *logger)
{
    if (d->light_count > ENVLT_MAX_LIGHTS)
        return envlt__refuse(logger, "desc.light_count", d->light_count, "0 (= 128) or 1..8192",
                             ENVLT_ERR_DESC);
    if ((unsigned)d->method >= ENVLT_METHOD_COUNT)
        return envlt__refuse(logger, "desc.method", d->method, "one of envlt_method", ENVLT_ERR_DESC);
    if (!envlt__allocator_valid(d->system.allocator.alloc_fn, d->system.allocator.free_fn))
        return envlt__refuse_text(logger, "desc.system.allocator", "has one of its two functions",
                                  ENVLT_ERR_DESC);
    return ENVLT_OK;
}

/* Returns an object without lights, whose memory goes through its meter, or NULL if there is no memory. */
static envlt_lights *envlt__make_empty(const envlt_desc *d, const envlt_map *map, size_t texels)
{
    const envlt_allocator *a = &d->system.allocator;
    envlt__allocator inner = envlt__allocator_make(a->alloc_fn, a->free_fn, a->user);
    envlt_lights *l = (envlt_lights *)envlt__alloc(&inner, sizeof *l);
    if (!l) return NULL;
    memset(l, 0, sizeof *l);
    l->meter.inner = inner;
    l->meter.now = l->meter.peak = sizeof *l;
    l->allocator = envlt__allocator_make(envlt__meter_alloc, envlt__meter_free, &l->meter);
    l->desc = *d;
    l->map = *map;
    l->map.rgb = NULL;
    l->texels = texels;
    return l;
}

/* Makes lights of a map; desc and map have been checked, and desc has its defaults. Fails with
   ENVLT_ERR_ALLOC alone, which the caller logs. */
static envlt_result envlt__make_lights(const envlt_desc *d, const envlt_map *map, size_t texels,
                                       envlt_lights **out, envlt_stats *stats)
{
    envlt__grid grid;
    envlt_result result;
    envlt_lights *l = envlt__make_empty(d, map, texels);
    if (!l) return ENVLT_ERR_ALLOC;
    memset(&grid, 0, sizeof grid);
    result = envlt__make_grid(&grid, map, d->hemisphere, ENVLT_NO_LIGHT, &l->allocator);
    l->roll = grid.roll;
    l->strata = (uint32_t *)envlt__alloc_array(&l->allocator, texels, sizeof *l->strata);
    l->order = (uint32_t *)envlt__alloc_array(&l->allocator, texels, sizeof *l->order);
    if (result == ENVLT_OK && (!l->strata || !l->order || !envlt__reserve_lights(l, d->light_count + 6)))
        result = ENVLT_ERR_ALLOC;
    if (result == ENVLT_OK) result = envlt__build_lights(l, &grid);
    envlt__free(&l->allocator, grid.memory);
    if (result != ENVLT_OK) {
        envlt_free(l);
        return result;
    }
    if (stats) envlt__fill_stats(l, &grid, stats);
    *out = l;
    return ENVLT_OK;
}

ENVLT_DEF envlt_result envlt_create(const envlt_desc *desc, const envlt_map *map, envlt_lights **out,
                                    envlt_stats *stats)
{
    envlt__logger logger;
    envlt_desc d;
    envlt_result result;
    size_t texels = 0;

    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    logger = envlt__make_logger(&d.system, "envlt_create");
    if (!map) return envlt__refuse_text(&logger, "map", "is NULL", ENVLT_ERR_ARGUMENT);
    if (!out) return envlt__refuse_text(&logger, "out", "is NULL", ENVLT_ERR_ARGUMENT);
    result = envlt__check_desc(&d, &logger);
    if (result == ENVLT_OK) result = envlt__check_map(map, &texels, &logger);
    if (result != ENVLT_OK) return result;
    if (!d.light_count) d.light_count = 128;
    if (d.method == ENVLT_METHOD_DEFAULT) d.method = ENVLT_METHOD_VARIANCE;
    return envlt__end_call(&logger, envlt__make_lights(&d, map, texels, out, stats));
}

ENVLT_DEF void envlt_free(envlt_lights *l)
{
    envlt__allocator inner;
    if (!l) return;
    inner = l->meter.inner;
    envlt__free(&l->allocator, l->cdf);
    envlt__free(&l->allocator, l->start);
    envlt__free(&l->allocator, l->sums);
    envlt__free(&l->allocator, l->list);
    envlt__free(&l->allocator, l->order);
    envlt__free(&l->allocator, l->strata);
    envlt__free(&inner, l);
}

ENVLT_DEF const envlt_light *envlt_get_lights(const envlt_lights *lights, uint32_t *count)
{
    if (count) *count = lights ? lights->count : 0;
    return lights ? lights->list : NULL;
}

ENVLT_DEF const uint32_t *envlt_strata(const envlt_lights *lights, size_t *count)
{
    if (count) *count = lights ? lights->texels : 0;
    return lights ? lights->strata : NULL;
}

/* ---- jitter ---- */

ENVLT_DEF envlt_result envlt_jitter(const envlt_lights *l, uint32_t frame, uint32_t seed, envlt_light *out)
{
    uint32_t i;
    envlt__logger logger;
    if (!l) return ENVLT_ERR_ARGUMENT;
    logger = envlt__make_logger(&l->desc.system, "envlt_jitter");
    if (!out && l->count) return envlt__refuse_text(&logger, "out", "is NULL", ENVLT_ERR_ARGUMENT);
    for (i = 0; i < l->count; i++) {
        uint32_t hash = envlt__hash_combine(seed, l->list[i].id), t, row, column;
        uint32_t first = l->start[i], a, b;
        envlt__cdf cdf;
        envlt__cdf_sample s;
        double d[3], length;
        out[i] = l->list[i];
        if (first == l->start[i + 1]) continue;         /* the sun has taken all texels of this stratum */
        /* Points of the R2 sequence, shifted by a hash of the light. The first coordinate chooses the texel,
           and what is left of it says how far across the texel; the second says how far down. */
        a = 0x80000000u + frame * 3242174889u + hash;
        b = 0x80000000u + frame * 2447445413u + envlt__hash32(hash);
        cdf.sums = l->cdf + first + i;
        cdf.count = l->start[i + 1] - first;
        s = envlt__cdf_sample_at(&cdf, envlt__to_unit(a));
        t = l->order[first + s.index];
        row = t / l->map.width;
        column = (uint32_t)(((uint64_t)t % l->map.width + l->roll) % l->map.width);
        envlt__direction(&l->map, row / l->map.height, (double)column + (double)s.fraction,
                         (double)(row % l->map.height) + (double)envlt__to_unit(b), d);
        length = 1.0 / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        for (row = 0; row < 3; row++) out[i].direction[row] = (float)(d[row] * length);
    }
    return ENVLT_OK;
}
