/* ---- scene: many instances ---- */

static void cohsm__flush_tile(cohsm__tile *t, const float *inverse, float *visible)
{
    size_t i;
    cohsm__load_tile(t, inverse);
    cohsm__run_tile(t);
    for (i = 0; i < t->count; i++) {
        float *v = visible + t->id[i];
        if (t->visible[i] == COHSM_REFUSED) *v = COHSM_REFUSED;
        else *v *= t->visible[i];
    }
    t->count = 0;
}

/* Returns an upper bound of the angle between a direction and that of the map which answers for it, in
   radians: half a cell with NEAREST, one cell with filters that take neighbours. */
static float cohsm__cell_angle(const cohsm__header *h, cohsm_filter filter)
{
    const float cells = filter == COHSM_FILTER_NEAREST ? 0.5f : 1.0f, turn = 6.2832f * cells;
    const float a = turn / (float)h->side[0], b = 0.5f * turn / (float)h->side[1];
    /* A step in the octahedral square turns a direction by at most 6.2 times its length. */
    if (h->domain == COHSM_DOMAIN_OCTAHEDRAL) return 6.2f * 1.4143f * cells / (float)h->side[0] + 1e-3f;
    return sqrtf(a * a + b * b) + 1e-3f;
}

/* Returns the radius of a sphere, in radii of the maps' own, outside which nothing shadows: the maps' sphere
   and a pixel across for directions, for positions a sphere round the hull, whose corners lie up to 1.13
   times as far from the centre as its faces. */
static float cohsm__sphere_reach(const cohsm_maps *m, cohsm_light_kind kind)
{
    float reach = 0.0f;
    int i;
    if (kind == COHSM_LIGHT_DIRECTION) return 1.0f + 2.83f / (float)m->head.map_side + 1e-3f;
    for (i = 0; i < 2 * COHSM__DOP_AXES; i++) {     /* axes have the lengths 1, sqrt(2) and sqrt(3) */
        const float d = fabsf(m->dop[i]) * (i < 6 ? 1.0f : i < 18 ? 0.70711f : 0.57736f);
        if (d > reach) reach = d;
    }
    return 1.13f * reach + 1e-3f;
}

static cohsm__sphere cohsm__sphere_of(const cohsm_instance *instance, const cohsm_query *q)
{
    const cohsm__header *h = &instance->maps->head;
    const float *transform = cohsm__m4_or_identity(instance->transform);
    const cohsm__v3 c = cohsm__m4_point(transform, cohsm__v3_load(h->center));
    const float scale = cohsm__v3_length(cohsm__v3_load(transform));
    float angle = 0.0f, sine, cosine;
    cohsm__sphere s;
    s.x = c.x;
    s.y = c.y;
    s.z = c.z;
    s.radius = cohsm__sphere_reach(instance->maps, q->light_kind) * h->radius * scale +
               COHSM__SLACK * (fabsf(c.x) + fabsf(c.y) + fabsf(c.z));
    if (q->light_kind == COHSM_LIGHT_DIRECTION) {
        angle = cohsm__cell_angle(h, q->filter);
        /* Pixels that nothing hits may shadow anything; a few cells are too wide to be worth a test. */
        if (h->self_only || angle >= 1.0f) {
            angle = 0.0f;
            s.radius = (float)HUGE_VAL;
        }
    }
    cohsm__sincos(angle, &sine, &cosine);
    s.cone_radius = s.radius / cosine;
    s.slope = sine / cosine;
    return s;
}

/* An instance's number, a block of the query's samples, and a bit for each that may have to ask it. */
typedef struct cohsm__asking {
    const cohsm_instance *instance;
    uint32_t       number;
    const uint32_t *asked;
    size_t         begin, count;
} cohsm__asking;

/* Asks one instance for those of a block's samples that still see some light. */
static void cohsm__ask_instance(cohsm__tile *t, const cohsm_query *q, const cohsm__asking *a, float *visible)
{
    float inverse[16];
    const size_t words = (a->count + 31) / 32;
    size_t word, i, n = 0;
    uint32_t bits;
    int started = 0;

    for (word = 0; word < words; word++) {
        bits = a->asked[word];
        if (!bits) continue;
        if (!started) {
            cohsm__tile_start(t, q, a->instance->maps, a->number);
            cohsm__m4_affine_inverse(inverse, cohsm__m4_or_identity(a->instance->transform));
            started = 1;
        }
        for (; bits; bits &= bits - 1u) {
            i = a->begin + 32 * word + cohsm__first_bit_plain(bits);
            t->id[n] = i;
            n += visible[i] > 0.0f;
            if (n < COHSM__TILE) continue;
            t->count = n;
            cohsm__flush_tile(t, inverse, visible);
            n = 0;
        }
    }
    t->count = n;
    if (n) cohsm__flush_tile(t, inverse, visible);
}

/* Finds the samples that a bunch of instances, from number `first` on, must be asked for: if own is 1, those
   that lie on one of them; if 0, all others whose rays may meet it. A sample of entity 0 lies on none. */
static void cohsm__find_asked(cohsm__bunch *b, const cohsm_instance *bunch, uint32_t first,
                              const cohsm_query *q, size_t begin, size_t count, int own, int tested)
{
    uint32_t j;
    size_t i;

    memset(b->asked, own || tested ? 0 : 0xff, sizeof b->asked);
    if (!own && tested) {
        for (j = 0; j < b->count; j++) b->sphere[j] = cohsm__sphere_of(&bunch[j], q);
        cohsm__choose_kernels(bunch->maps->simd).meet_spheres(q, begin, count, b);
    }
    for (j = 0; j < b->count && count % 32; j++) b->asked[j][count / 32] &= (1u << count % 32) - 1u;
    for (i = 0; q->entities && i < count; i++) {
        j = q->entities[begin + i] - 1u - first;
        if (j >= b->count) continue;
        if (own) b->asked[j][i / 32] |= 1u << i % 32;
        else b->asked[j][i / 32] &= ~(1u << i % 32);
    }
}

static cohsm_result cohsm__check_instance(const cohsm_instance *instance, size_t number, const cohsm_query *q,
                                          const cohsm__logger *log)
{
    const float *m = cohsm__m4_or_identity(instance->transform);
    float inverse[16], scale;

    if (!instance->maps) {
        cohsm__log_element_text(log, "instances", number, "has no maps");
        return COHSM_ERR_ARGUMENT;
    }
    if (!cohsm__m4_is_rigid_uniform(m, &scale) || !cohsm__m4_affine_inverse(inverse, m)) {
        cohsm__v3 z = cohsm__v3_cross(cohsm__v3_load(m), cohsm__v3_load(m + 4));
        cohsm__log_element(log, "instances", number, "has a transform of the determinant",
                           (double)cohsm__v3_dot(z, cohsm__v3_load(m + 8)),
                           "a rotation, one scale > 0 and a translation");
        return COHSM_ERR_INPUT;
    }
    return q->count ? cohsm__check_query(instance->maps, q, log) : COHSM_OK;
}

/* Returns the log of the first instance that has maps. If count is larger than any scene can be, the function
   looks at the first instance alone. */
static cohsm__logger cohsm__logger_of_scene(const cohsm_instance *instances, size_t count)
{
    const cohsm_maps *maps = NULL;
    size_t i, end = !instances ? 0 : count < UINT32_MAX ? count : 1;
    for (i = 0; i < end && !maps; i++) maps = instances[i].maps;
    return cohsm__logger_of_maps(maps, "cohsm_visible_scene");
}

/* Asks all instances for a block of samples: first, for each sample, the instance that it lies on, then the
   others in the order of the list. */
static void cohsm__ask_block(cohsm__tile *t, const cohsm_instance *instances, uint32_t instance_count,
                             const cohsm_query *q, size_t begin, size_t count, float *visible)
{
    /* The spheres of few instances are not worth their test. */
    const int tested = instance_count >= 4 &&
                       (q->light_kind == COHSM_LIGHT_DIRECTION || q->light_kind == COHSM_LIGHT_POSITION);
    cohsm__bunch b;
    cohsm__asking a;
    uint32_t first, j;
    int own;

    a.begin = begin;
    a.count = count;
    for (own = q->entities != NULL; own >= 0; own--)
        for (first = 0; first < instance_count; first += b.count) {
            b.count = cohsm__min_u32(instance_count - first, COHSM__BUNCH);
            cohsm__find_asked(&b, instances + first, first, q, begin, count, own, tested);
            for (j = 0; j < b.count; j++) {
                a.instance = &instances[first + j];
                a.number = first + j;
                a.asked = b.asked[j];
                cohsm__ask_instance(t, q, &a, visible);
            }
        }
}

COHSM_DEF cohsm_result cohsm_visible_scene(const cohsm_instance *instances, size_t instance_count,
                                           const cohsm_query *query, float *visible, size_t *refused)
{
    cohsm__tile t;
    cohsm_query q;
    size_t i, n;
    cohsm__logger log = cohsm__logger_of_scene(instances, instance_count);
    cohsm_result result;

    if (!query) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "query", "is NULL");
    if (query->count && !visible) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "visible", "is NULL");
    if (instance_count && !instances) return COHSM_ERR_ARGUMENT;
    if (instance_count >= UINT32_MAX) {
        cohsm__log_value(&log, "instance_count", (double)instance_count, "below 2^32 - 1");
        return COHSM_ERR_LIMIT;
    }
    for (i = 0; i < instance_count; i++) {
        result = cohsm__check_instance(&instances[i], i, query, &log);
        if (result != COHSM_OK) return result;
    }
    q = cohsm__complete_query(query);
    if (instance_count == 1) q.entities = NULL;             /* entities decide the order alone */
    for (i = 0; i < q.count; i++) visible[i] = 1.0f;
    for (i = 0; i < q.count; i += n) {
        n = q.count - i < COHSM__BLOCK ? q.count - i : (size_t)COHSM__BLOCK;
        cohsm__ask_block(&t, instances, (uint32_t)instance_count, &q, i, n, visible);
    }
    if (refused) *refused = cohsm__count_refused(visible, query->count);
    return COHSM_OK;
}
