/* ---- lists of pixel lights, and clusters of them ---- */

RSM_DEF rsm_result rsm_pixel_lights(const rsm_map *const *maps, size_t map_count, uint32_t sample_count,
                                    uint32_t seed, rsm_texel *lights, size_t capacity, size_t *count)
{
    rsm__logger log =
        rsm__logger_of(maps && map_count && maps[0] ? &maps[0]->desc.system : NULL, "rsm_pixel_lights");
    size_t m, i, needed = 0, at = 0;
    rsm_result result = rsm__maps_check(&log, maps, map_count);
    if (result != RSM_OK) return result;
    if (!count) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "count", "is NULL");
    if (!lights && capacity) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "lights", "is NULL");
    if (!rsm__check_range(&log, "sample_count", sample_count, 0, RSM__MAX_SAMPLES, "0..2^20"))
        return RSM_ERR_ARGUMENT;
    for (m = 0; m < map_count; m++) {
        float weight;
        if (!sample_count) needed += (size_t)maps[m]->stats.lit_texels;
        for (i = 0; i < sample_count; i++)
            needed += (size_t)rsm__pick_texel(maps[m], (uint32_t)i, sample_count, seed, &at, &weight);
    }
    *count = needed;
    if (capacity < needed) {
        rsm__log_bound(&log, "capacity", capacity, "at least", needed, "which *count says");
        return RSM_ERR_MEMORY;
    }
    for (m = 0, needed = 0; m < map_count; m++)
        for (i = 0; i < (sample_count ? sample_count : rsm__texel_count(maps[m])); i++) {
            float weight = 1.0f;
            int c;
            at = i;
            if (sample_count ? !rsm__pick_texel(maps[m], (uint32_t)i, sample_count, seed, &at, &weight)
                        : !(rsm__mean3(maps[m]->texels[at].flux) > 0.0f))
                continue;
            lights[needed] = maps[m]->texels[at];
            lights[needed].area *= weight;
            for (c = 0; c < 3; c++) lights[needed].flux[c] *= weight;
            needed++;
        }
    return RSM_OK;
}

typedef struct rsm__group {        /* a group of lights: `count` entries of the order from `first` on */
    size_t first, count;
    double flux;
    double mean[6], spread[6];     /* of positions and normals, weighted by flux */
    double cost;                   /* flux x spread: the costliest group is cut next */
} rsm__group;

/* Returns coordinate k of a light: 0 to 2 of its position, 3 to 5 of its normal. */
static inline float rsm__coordinate(const rsm_texel *t, int k)
{
    return k < 3 ? t->position[k] : t->normal[k - 3];
}

/* Measures the means and spreads of a group, and its cost. Spreads of normals are scaled to those of
   positions by size2, the squared size of the scene. */
static inline void rsm__measure_group(rsm__group *g, const rsm_texel *lights, const uint32_t *order,
                                      double size2)
{
    size_t i;
    int k;
    g->flux = g->cost = 0.0;
    for (k = 0; k < 6; k++) g->mean[k] = g->spread[k] = 0.0;
    for (i = 0; i < g->count; i++) {
        const rsm_texel *t = lights + order[g->first + i];
        double f = (double)rsm__mean3(t->flux);
        g->flux += f;
        for (k = 0; k < 6; k++) {
            double v = (double)rsm__coordinate(t, k);
            g->mean[k] += f * v;
            g->spread[k] += f * v * v;
        }
    }
    for (k = 0; k < 6 && g->flux > 0.0; k++) {
        g->mean[k] /= g->flux;
        g->spread[k] = (g->spread[k] / g->flux - g->mean[k] * g->mean[k]) * (k < 3 ? 1.0 : 0.25 * size2);
        if (!(g->spread[k] > 0.0)) g->spread[k] = 0.0;
        g->cost += g->spread[k] * g->flux;
    }
    if (g->count < 2) g->cost = 0.0;
}

/* Cuts a group at the mean of its widest coordinate. Returns 0 if all lights fall on one side. */
static inline int rsm__cut_group(rsm__group *g, rsm__group *other, const rsm_texel *lights, uint32_t *order,
                                 double size2)
{
    size_t low = g->first, high = g->first + g->count;
    int k, widest = 0;
    for (k = 1; k < 6; k++)
        if (g->spread[k] > g->spread[widest]) widest = k;
    while (low < high) {
        uint32_t swap = order[low];
        if ((double)rsm__coordinate(lights + swap, widest) < g->mean[widest]) low++;
        else {
            order[low] = order[--high];
            order[high] = swap;
        }
    }
    if (low == g->first || low == g->first + g->count) return 0;
    other->first = low;
    other->count = g->first + g->count - low;
    g->count = low - g->first;
    rsm__measure_group(g, lights, order, size2);
    rsm__measure_group(other, lights, order, size2);
    return 1;
}

/* Writes the light that stands for a group. */
static inline void rsm__group_light(const rsm__group *g, const rsm_texel *lights, const uint32_t *order,
                                    rsm_texel *out)
{
    double flux[3] = { 0, 0, 0 }, area = 0.0;
    const rsm_texel *brightest = lights + order[g->first];
    rsm__v3 normal = rsm__v3_make((float)g->mean[3], (float)g->mean[4], (float)g->mean[5]);
    size_t i;
    int c;
    rsm__texel_clear(out);
    for (i = 0; i < g->count; i++) {
        const rsm_texel *t = lights + order[g->first + i];
        if (rsm__mean3(t->flux) > rsm__mean3(brightest->flux)) brightest = t;
        for (c = 0; c < 3; c++) flux[c] += (double)t->flux[c];
        area += (double)t->area;
    }
    for (c = 0; c < 3; c++) {
        out->position[c] = (float)g->mean[c];
        out->flux[c] = (float)flux[c];
    }
    out->area = (float)area;
    out->depth = 0.0f;
    if (!(rsm__v3_length(normal) > 1e-6f))
        normal = rsm__v3_load(brightest->normal); /* since opposite normals cancel out */
    rsm__v3_store(out->normal, rsm__v3_normalize(normal));
}

RSM_DEF rsm_result rsm_cluster(const rsm_texel *lights, size_t light_count, uint32_t cluster_count,
                               const rsm_system *system, rsm_texel *clusters, size_t *count)
{
    rsm__logger log;
    rsm_system none;
    rsm__allocator a;
    rsm_result result;
    rsm__group *groups;
    uint32_t *order, found = 1, i;
    uint32_t k, most;
    size_t used = 0, at;
    double size2 = 0.0;
    memset(&none, 0, sizeof none);
    if (!system) system = &none;
    log = rsm__logger_of(system, "rsm_cluster");
    if (!clusters) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "clusters", "is NULL");
    if (!count) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "count", "is NULL");
    if (!rsm__check_range(&log, "cluster_count", cluster_count, 1, 65536, "1..65536"))
        return RSM_ERR_ARGUMENT;
    if (!rsm__check_range(&log, "light_count", (double)light_count, 0, 0x7fffffff, "below 2^31"))
        return RSM_ERR_LIMIT;
    if (!rsm__system_valid(&log, system)) return RSM_ERR_DESC;
    result = rsm__lights_check(&log, lights, light_count);
    if (result != RSM_OK) return result;
    a = rsm__allocator_of(system);
    order = (uint32_t *)rsm__alloc_array(&a, light_count + 1, sizeof *order);
    groups = (rsm__group *)rsm__alloc_array(&a, cluster_count, sizeof *groups);
    if (!order || !groups) {
        rsm__free(&a, groups);
        rsm__free(&a, order);
        return rsm__refuse(&log, RSM_ERR_ALLOC, "the allocator", "returned no memory for groups of lights");
    }
    for (at = 0; at < light_count; at++) {
        float f = rsm__mean3(lights[at].flux);
        if (f > 0.0f && f <= 1e18f && rsm__is_usable(rsm__v3_load(lights[at].position)) &&
            rsm__is_usable(rsm__v3_load(lights[at].normal)))
            order[used++] = (uint32_t)at;
    }
    groups[0].first = 0;
    groups[0].count = used;
    rsm__measure_group(groups, lights, order, 0.0);
    for (k = 0; k < 3; k++) size2 += groups[0].spread[k];
    rsm__measure_group(groups, lights, order, size2);
    while (used && found < cluster_count) {
        most = 0;
        for (i = 1; i < found; i++)
            if (groups[i].cost > groups[most].cost) most = i;
        if (!(groups[most].cost > 0.0)) break;
        if (rsm__cut_group(groups + most, groups + found, lights, order, size2)) found++;
        else groups[most].cost = 0.0;
    }
    for (i = 0; used && i < found; i++) rsm__group_light(groups + i, lights, order, clusters + i);
    *count = used ? found : 0;
    rsm__free(&a, groups);
    rsm__free(&a, order);
    return RSM_OK;
}
