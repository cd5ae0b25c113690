/* ---- sun: the spot that gets a light of its own ---- */

/* Finds the sun: the connected spot about the brightest texel in which luminance is above a tenth of the
   greatest. It must be smaller than 0.03 sr (11 degrees across) and have a light's share of the energy.
   Writes its texels to the queue, which has room for all texels, and returns how many they are; 0 if there is
   no sun. */
static uint32_t envlt__find_sun(const envlt__grid *g, uint32_t k, uint32_t *queue, uint8_t *seen)
{
    uint32_t head = 0, tail = 0, next[4], i;
    size_t t, top = 0;
    double energy = 0.0, omega = 0.0;
    for (t = 1; t < g->count; t++)
        if (g->lum[t] > g->lum[top]) top = t;
    if (!(g->lum[top] > 0.0f)) return 0;
    memset(seen, 0, g->count);
    queue[tail++] = (uint32_t)top;
    seen[top] = 1;
    while (head < tail && omega < 0.03) {
        t = queue[head++];
        energy += envlt__texel_weight(g, t);
        omega += (double)g->omega[t];
        envlt__neighbours(g, (uint32_t)t, next);
        for (i = 0; i < 4; i++)
            if (!seen[next[i]] && g->lum[next[i]] > 0.1f * g->lum[top]) {
                seen[next[i]] = 1;
                queue[tail++] = next[i];
            }
    }
    return head == tail && omega < 0.03 && energy * k >= g->total && k > 1 ? tail : 0;
}

/* Returns how many texels are lit. If label is not NULL, texels with label 0, those of the sun, do not count.
   */
static size_t envlt__count_lit(const envlt__grid *g, const uint32_t *label)
{
    size_t t, lit = 0;
    for (t = 0; t < g->count; t++) lit += g->lum[t] > 0.0f && !(label && label[t] == 0);
    return lit;
}

/* ---- strata: what is kept of a map ---- */

/* Writes which light each texel of the map belongs to, and lists the texels of each stratum. */
static void envlt__sort_strata(envlt_lights *l, const envlt__grid *g, const uint32_t *label)
{
    uint32_t i, x = 0;
    size_t t;
    for (i = 0; i <= l->count; i++) l->start[i] = 0;
    for (t = 0; t < g->count; t++, x = x + 1 < g->width ? x + 1 : 0) {
        uint32_t s = g->omega[t] > 0.0f && l->count ? label[t] : ENVLT_NO_LIGHT;
        l->strata[envlt__map_texel(g, t - x, x)] = s;
        if (s != ENVLT_NO_LIGHT) l->start[s]++;
    }
    for (i = 0, t = 0; i <= l->count; i++) {
        size_t n = l->start[i];
        l->start[i] = (uint32_t)t;
        t += i < l->count ? n : 0;
    }
    for (t = 0; t < g->count; t++)          /* texels of a stratum stand in the grid's order */
        if (g->omega[t] > 0.0f && l->count) l->order[l->start[label[t]]++] = (uint32_t)t;
    for (i = l->count; i > 0; i--) l->start[i] = l->start[i - 1];
    l->start[0] = 0;
}

/* Fills in the running sums by which envlt_jitter chooses texels. The strata must not change afterwards. */
static void envlt__fill_cdf(envlt_lights *l, const envlt__grid *g)
{
    uint32_t i, j;
    for (i = 0; i < l->count; i++) {
        double sum = 0.0, *out = l->cdf + l->start[i] + i;
        for (j = l->start[i]; j < l->start[i + 1]; j++) {
            *out++ = sum;
            sum += envlt__texel_weight(g, l->order[j]);
        }
        *out = sum;
    }
}

/* Makes the lights of their sums, each towards its chosen texel or, without any, its stratum's mean. */
static void envlt__fill_lights(envlt_lights *l, const envlt__grid *g, const uint32_t *chosen)
{
    uint32_t i;
    for (i = 0; i < l->count; i++) {
        /* The light of a stratum that a video has made black keeps its direction. */
        if (l->sums[i].w > 0.0) {
            envlt__make_light(g, &l->sums[i], chosen ? chosen[i] : ENVLT_NO_LIGHT, &l->list[i]);
        } else {
            l->list[i].irradiance[0] = l->list[i].irradiance[1] = l->list[i].irradiance[2] = 0.0f;
            l->list[i].solid_angle = (float)l->sums[i].omega;
        }
        l->list[i].flags = l->has_sun && i == 0 ? ENVLT_LIGHT_SUN : 0;
    }
}

/* Makes room for k lights, more or less than there are, and keeps those that there are. Returns 0 if there is
   no memory. */
static int envlt__reserve_lights(envlt_lights *l, uint32_t k)
{
    const envlt__allocator *a = &l->allocator;
    envlt_light *list = (envlt_light *)envlt__alloc_array(a, (size_t)k + 1, sizeof *list);
    envlt__sums *sums = (envlt__sums *)envlt__alloc_array(a, (size_t)k + 1, sizeof *sums);
    uint32_t *start = (uint32_t *)envlt__alloc_array(a, (size_t)k + 2, sizeof *start);
    double *cdf = (double *)envlt__alloc_array(a, l->texels + k + 1, sizeof *cdf);
    if (!list || !sums || !start || !cdf) {
        envlt__free(a, cdf);
        envlt__free(a, start);
        envlt__free(a, sums);
        envlt__free(a, list);
        return 0;
    }
    memset(list, 0, ((size_t)k + 1) * sizeof *list);
    if (l->list) {
        memcpy(list, l->list, l->count * sizeof *list);
        memcpy(sums, l->sums, l->count * sizeof *sums);
        memcpy(start, l->start, ((size_t)l->count + 1) * sizeof *start);
    }
    envlt__free(a, l->cdf);
    envlt__free(a, l->start);
    envlt__free(a, l->sums);
    envlt__free(a, l->list);
    l->list = list;
    l->sums = sums;
    l->start = start;
    l->cdf = cdf;
    return 1;
}

/* Logs that a side of the map is not that of the map before, which is wanted. */
static envlt_result envlt__refuse_other(const envlt__logger *logger, const char *field, uint32_t value,
                                        uint32_t wanted)
{
    envlt__message text;
    text.used = 0;
    envlt__message_count(&text, wanted);
    envlt__message_text(&text, ", as that of the map before");
    return envlt__refuse(logger, field, value, text.text, ENVLT_ERR_MISMATCH);
}

/* Checks whether a map has the size and projection of the one that the lights were made of. */
static envlt_result envlt__check_same(const envlt_lights *l, const envlt_map *map,
                                      const envlt__logger *logger)
{
    size_t texels;
    envlt_result result;
    if (!map) return envlt__refuse_text(logger, "map", "is NULL", ENVLT_ERR_ARGUMENT);
    result = envlt__check_map(map, &texels, logger);
    if (result != ENVLT_OK) return result;
    if (map->width != l->map.width)
        return envlt__refuse_other(logger, "map.width", map->width, l->map.width);
    if (map->height != l->map.height)
        return envlt__refuse_other(logger, "map.height", map->height, l->map.height);
    if (texels != l->texels)
        return envlt__refuse_text(logger, "map.projection", "is not that of the map before",
                                  ENVLT_ERR_MISMATCH);
    return ENVLT_OK;
}
