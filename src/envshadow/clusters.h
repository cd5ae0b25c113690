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
        return envsh__refuse_text(&logger, "capacity", "is 0: no light has room", ENVSH_ERR_ARGUMENT);
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
