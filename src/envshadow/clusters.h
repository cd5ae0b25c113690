/* ---- clusters: algorithm 2, some lights at a time ---- */

/* Returns the address of element `first` of an array, or NULL for NULL. */
static const float *envsh__skip_items(const float *base, size_t stride, uint32_t first)
{
    return base ? (const float *)(const void *)((const char *)base + first * (stride ? stride : 12)) : NULL;
}

/* Returns the lights from number `first` on, as many as the maps hold. */
static envsh_lights envsh__cluster_at(const envsh_lights *lights, uint32_t first, uint32_t capacity)
{
    envsh_lights part = *lights;
    part.count = lights->count - first < capacity ? lights->count - first : capacity;
    part.directions = envsh__skip_items(lights->directions, lights->stride, first);
    part.irradiances = envsh__skip_items(lights->irradiances, lights->stride, first);
    part.axes_u = envsh__skip_items(lights->axes_u, lights->stride, first);
    part.axes_v = envsh__skip_items(lights->axes_v, lights->stride, first);
    return part;
}

ENVSH_DEF envsh_result envsh_illuminate(envsh_maps *maps, const envsh_lights *lights, envsh_bounds bounds,
                                        envsh_draw_fn draw_fn, void *user, const envsh_query *query,
                                        const envsh_points *points, float *irradiance)
{
    envsh_query q;
    envsh_lights part;
    envsh__logger logger;
    envsh_result result;
    uint32_t first = 0, count = lights ? lights->count : 0;
    if (!maps) return ENVSH_ERR_ARGUMENT;
    logger = envsh__make_logger(&maps->system, "envsh_illuminate");
    if (!draw_fn) return envsh__refuse_text(&logger, "draw_fn", "is NULL", ENVSH_ERR_ARGUMENT);
    if (maps->no_depth) return envsh__refuse_no_depth(&logger);
    if (!maps->capacity && count)
        return envsh__refuse_text(&logger, "capacity", "is 0: no light has room", ENVSH_ERR_LIMIT);
    result = lights ? envsh__check_lights(lights, &logger) : ENVSH_OK;
    if (result == ENVSH_OK) result = envsh__check_bounds(&bounds, &logger);
    if (result == ENVSH_OK) result = envsh__check_query(query, &q, &logger);
    if (result == ENVSH_OK) result = envsh__check_points(points, irradiance, "irradiance", &logger);
    if (result != ENVSH_OK) return result;
    memset(&part, 0, sizeof part);
    do {
        if (lights) part = envsh__cluster_at(lights, first, maps->capacity);
        maps->told = count ? (float)first / (float)count : 0.0f;
        maps->span = 0.0f;
        result = envsh_maps_begin(maps, &part, bounds);
        if (result == ENVSH_OK && part.count) result = draw_fn(user, maps);
        if (result == ENVSH_OK) result = envsh_maps_end(maps);
        maps->span = (count ? (float)(first + part.count) / (float)count : 1.0f) - maps->told;
        if (result == ENVSH_OK) result = envsh__check_finished(maps, &logger);
        if (result == ENVSH_OK) result = envsh__run_shading(maps, &q, points, irradiance, ENVSH__ALL);
        q.add = 1;
        first += part.count;
    } while (result == ENVSH_OK && first < count);
    maps->told = 0.0f;
    maps->span = 1.0f;
    return result;
}

/* ---- cost: what a pass and a light cost, from measured times ---- */

ENVSH_DEF int envsh_cost_fit(uint32_t light_count, const uint32_t *clusters, const double *ms, size_t count,
                             envsh_cost *out)
{
    double aa = 0.0;
    double ab = 0.0;
    double bb = 0.0;
    double at = 0.0;
    double bt = 0.0;
    double det;
    size_t i;
    if (!clusters || !ms || !out || !light_count) return 0;
    for (i = 0; i < count; i++) {
        double passes, slots;
        if (!clusters[i] || !(ms[i] >= 0.0 && ms[i] < 1e12)) return 0;
        passes = (double)((light_count - 1) / clusters[i] + 1);
        slots = passes * (double)clusters[i];
        /* Least squares of relative errors: each row is divided by its time. */
        passes /= ms[i] + 1e-9;
        slots /= ms[i] + 1e-9;
        aa += passes * passes;
        ab += passes * slots;
        bb += slots * slots;
        at += passes * ms[i] / (ms[i] + 1e-9);
        bt += slots * ms[i] / (ms[i] + 1e-9);
    }
    det = aa * bb - ab * ab;
    if (!(det > 1e-9 * aa * bb)) return 0;
    out->pass = (at * bb - bt * ab) / det;
    out->slot = (bt * aa - at * ab) / det;
    if (out->pass < 0.0) {                  /* by noise; then the other cost explains all of the times */
        out->pass = 0.0;
        out->slot = bt / bb;
    } else if (out->slot < 0.0) {
        out->slot = 0.0;
        out->pass = at / aa;
    }
    return 1;
}

ENVSH_DEF uint32_t envsh_cost_cluster(const envsh_cost *cost, uint32_t light_count, uint32_t most)
{
    uint32_t best = 1, c;
    double least = -1.0;
    if (!cost || !light_count || !most) return 1;
    most = most < light_count ? most : light_count;
    for (c = 1; c <= most; c++) {
        double passes = (double)((light_count - 1) / c + 1);
        double ms = passes * (cost->pass + (double)c * cost->slot);
        if (least >= 0.0 && ms >= least) continue;
        least = ms;
        best = c;
    }
    return best;
}
