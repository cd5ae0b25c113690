/* ---- seeing: one receiver and many lights, for headers that gather light ---- */

enum { COHSM__SEEN = 64 };              /* lights that are asked about at a time */

/* Writes the lights with these numbers one after another, 12 bytes apart, as a query reads them. */
static void cohsm__pick_lights(const cohsm_sight *s, const uint32_t *numbers, size_t count,
                               float lights[3 * COHSM__SEEN])
{
    const cohsm_query *q = &s->query;
    const size_t size = cohsm__light_size(s->instances[0].maps, q->light_kind);
    const size_t stride = q->light_stride ? q->light_stride : size;
    size_t i;

    memset(lights, 0, 3 * COHSM__SEEN * sizeof *lights);
    for (i = 0; i < count; i++)
        memcpy(lights + 3 * i,
               q->lights ? (const void *)((const char *)q->lights + stride * numbers[i])
                         : (const void *)(numbers + i),
               size);
}

/* Asks about up to COHSM__SEEN lights. Each receiver has random numbers of its own for ROULETTE, by the bits
   of its position. */
static cohsm_result cohsm__see_some(const cohsm_sight *s, const float position[3], const uint32_t *numbers,
                                    size_t count, float *visible)
{
    float positions[3 * COHSM__SEEN], lights[3 * COHSM__SEEN];
    cohsm_query q = s->query;
    uint32_t bits[3];
    size_t i;

    for (i = 0; i < count; i++) memcpy(positions + 3 * i, position, 3 * sizeof *position);
    if (q.lights || q.light_kind == COHSM_LIGHT_INDEX) {
        cohsm__pick_lights(s, numbers, count, lights);
        q.lights = lights;
    }
    memcpy(bits, position, sizeof bits);
    q.seed = cohsm__hash_combine(cohsm__hash_combine(cohsm__hash_combine(q.seed, bits[0]), bits[1]), bits[2]);
    q.positions = positions;
    q.position_stride = 12;
    q.light_stride = 12;
    q.count = count;
    q.one_light = 0;
    q.entities = NULL;
    return cohsm_visible_scene(s->instances, s->instance_count, &q, visible, NULL);
}

COHSM_DEF void cohsm_see(void *sight, const float position[3], const float normal[3],
                         const uint32_t *numbers, size_t count, float *visible)
{
    const cohsm_sight *s = (const cohsm_sight *)sight;
    size_t first, i, n;

    (void)normal;
    for (first = 0; first < count; first += n) {
        const int known = s->instance_count > 0 && s->instances && s->instances[0].maps;
        n = count - first < COHSM__SEEN ? count - first : (size_t)COHSM__SEEN;
        for (i = 0; i < n; i++) visible[first + i] = s->instance_count ? 0.0f : 1.0f;
        if (!known) continue;
        if (cohsm__see_some(s, position, numbers + first, n, visible + first) != COHSM_OK)
            for (i = 0; i < n; i++) visible[first + i] = 0.0f;
        for (i = 0; i < n; i++)
            if (visible[first + i] < 0.0f) visible[first + i] = 1.0f;
    }
}

COHSM_DEF void cohsm_light_locations(const float *positions, size_t position_stride, const float *normals,
                                     size_t normal_stride, size_t count, float lift, float *locations)
{
    const char *p = (const char *)(const void *)positions, *n = (const char *)(const void *)normals;
    size_t i;

    for (i = 0; i < count; i++, locations += 4) {
        float at[3], normal[3];
        memcpy(at, p + i * (position_stride ? position_stride : 12), sizeof at);
        memcpy(normal, n + i * (normal_stride ? normal_stride : 12), sizeof normal);
        cohsm__v3_store(locations,
                        cohsm__v3_add(cohsm__v3_load(at), cohsm__v3_scale(cohsm__v3_load(normal), lift)));
        locations[3] = 1.0f;
    }
}
