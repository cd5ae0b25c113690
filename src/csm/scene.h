/* ---- scene: samples to the objects' spaces and back ---- */

static size_t cohsm__light_size(const cohsm_maps *m, cohsm_light_kind kind)
{
    if (kind == COHSM_LIGHT_INDEX) return 4;
    return kind == COHSM_LIGHT_PARAMETER ? 4 * (size_t)m->head.dimensions : 12;
}

/* Loads the lights of the tile's samples, or the one light of all, and takes them to the object's space. */
static void cohsm__load_lights(cohsm__tile *t, const float *inverse)
{
    const cohsm_query *q = t->query;
    const cohsm__header *h = &t->maps->head;
    size_t size = cohsm__light_size(t->maps, q->light_kind),
           stride = q->light_stride ? q->light_stride : size, i;
    size_t count = t->one_light ? (t->count ? 1 : 0) : t->count;
    cohsm__v3 c = cohsm__v3_load(h->center), l;
    float per_radius = 1.0f / h->radius, v[3] = { 0, 0, 0 };

    i = 0;
    if (q->light_kind == COHSM_LIGHT_DIRECTION && !inverse && stride == 12 && !t->one_light)
        i = cohsm__choose_kernels(t->maps->simd)
                .load_vectors(t, (const float *)q->lights, cohsm__v3_make(0, 0, 0), 1.0f, t->light);
    for (; i < count; i++) {
        const char *from = (const char *)q->lights + stride * (t->one_light ? 0 : t->id[i]);
        if (q->light_kind == COHSM_LIGHT_INDEX) {
            memcpy(&t->cell[i], from, 4);
            continue;
        }
        if (q->light_kind == COHSM_LIGHT_PARAMETER) memcpy(v, from, size);
        else memcpy(v, from, sizeof v);
        l = cohsm__v3_load(v);
        if (q->light_kind == COHSM_LIGHT_DIRECTION && inverse) l = cohsm__m4_direction(inverse, l);
        if (q->light_kind == COHSM_LIGHT_POSITION && inverse) l = cohsm__m4_point(inverse, l);
        if (q->light_kind == COHSM_LIGHT_POSITION) l = cohsm__v3_scale(cohsm__v3_sub(l, c), per_radius);
        t->light[0][i] = l.x;
        t->light[1][i] = l.y;
        t->light[2][i] = l.z;
    }
}

static void cohsm__load_tile(cohsm__tile *t, const float *inverse)
{
    const cohsm_query *q = t->query;
    size_t stride = q->position_stride ? q->position_stride : 12, i = 0;
    cohsm__v3 c = cohsm__v3_load(t->maps->head.center), p;
    float per_radius = 1.0f / t->maps->head.radius, v[3];

    if (!inverse && stride == 12)
        i = cohsm__choose_kernels(t->maps->simd)
                .load_vectors(t, (const float *)(const void *)q->positions, c, per_radius, t->point);
    for (; i < t->count; i++) {
        memcpy(v, (const char *)q->positions + stride * t->id[i], sizeof v);
        p = cohsm__v3_load(v);
        if (inverse) p = cohsm__m4_point(inverse, p);
        p = cohsm__v3_scale(cohsm__v3_sub(p, c), per_radius);
        t->point[0][i] = p.x;
        t->point[1][i] = p.y;
        t->point[2][i] = p.z;
    }
    cohsm__load_lights(t, inverse);
}

/* Finds the cell of the light that all samples of a query have. Returns 0 if all samples are lit. */
static int cohsm__cell_of_query(const cohsm_maps *m, const cohsm_query *q, uint32_t *cell)
{
    float v[3] = { 0.0f, 0.0f, 0.0f };
    uint32_t index = 0;
    memcpy(q->light_kind == COHSM_LIGHT_INDEX ? (void *)&index : (void *)v, q->lights,
           cohsm__light_size(m, q->light_kind));
    return cohsm__cell_of_light(m, q->light_kind, cohsm__v3_load(v), index, cell);
}

/* Answers the whole batch at once if all points have one light; returns 0 if the batch is one that is treated
   in tiles. */
static int cohsm__run_stream(const cohsm_maps *m, const cohsm_query *q, float *visible)
{
    const cohsm__kernels kernels = cohsm__choose_kernels(m->simd);
    int32_t key[COHSM__STREAM], depth[COHSM__STREAM];
    uint32_t list[COHSM__STREAM], cell;
    cohsm__stream s;
    cohsm__kept kept;
    size_t first;

    if (!q->count || !q->one_light || q->filter != COHSM_FILTER_NEAREST ||
        q->light_kind == COHSM_LIGHT_POSITION)
        return 0;
    if (!cohsm__cell_of_query(m, q, &cell)) {
        for (first = 0; first < q->count; first++) visible[first] = 1.0f;
        return 1;
    }
    cohsm__keep_nothing(&kept);
    cohsm__stream_make(&s, m, cell, q->bias, &kept);
    s.stride = q->position_stride ? q->position_stride : 12;
    s.key = key;
    s.depth = depth;
    s.list = list;
    for (first = 0; first < q->count; first += s.count) {
        s.count = q->count - first < COHSM__STREAM ? q->count - first : (size_t)COHSM__STREAM;
        s.points = (const char *)(const void *)q->positions + s.stride * first;
        kernels.one_light(&s, visible + first);
    }
    return 1;
}

/* Says whether maps can answer for lights of the query's kind. */
static cohsm_result cohsm__check_light_kind(const cohsm_maps *m, const cohsm_query *q,
                                            const cohsm__logger *log)
{
    const double kind = (double)q->light_kind;

    if (q->light_kind == COHSM_LIGHT_INDEX) return COHSM_OK;
    if (q->light_kind == COHSM_LIGHT_PARAMETER) {
        if (m->head.dimensions) return COHSM_OK;
        cohsm__log_value(log, "query.light_kind", kind,
                         "COHSM_LIGHT_INDEX: maps of a LIST have no parameters");
        return COHSM_ERR_MISMATCH;
    }
    if (m->head.domain == COHSM_DOMAIN_LATLONG || m->head.domain == COHSM_DOMAIN_OCTAHEDRAL) return COHSM_OK;
    cohsm__log_value(log, "query.light_kind", kind,
                     "COHSM_LIGHT_PARAMETER or _INDEX: these are not maps of all directions");
    return COHSM_ERR_MISMATCH;
}

static cohsm_result cohsm__check_query(const cohsm_maps *m, const cohsm_query *q, const cohsm__logger *log)
{
    const char *stride = NULL;
    size_t bytes = 0;

    if (!q->positions) return cohsm__refuse(log, COHSM_ERR_ARGUMENT, "query.positions", "is NULL");
    if (!q->lights) return cohsm__refuse(log, COHSM_ERR_ARGUMENT, "query.lights", "is NULL");
    if ((unsigned)q->light_kind >= COHSM_LIGHT_COUNT)
        return cohsm__refuse_value(log, "query.light_kind", (double)q->light_kind, "a COHSM_LIGHT_...");
    if ((unsigned)q->filter >= COHSM_FILTER_COUNT)
        return cohsm__refuse_value(log, "query.filter", (double)q->filter, "a COHSM_FILTER_...");
    if (!cohsm__finite(q->bias)) return cohsm__refuse_value(log, "query.bias", (double)q->bias, "finite");
    if ((q->light_stride && q->light_stride < cohsm__light_size(m, q->light_kind)) || q->light_stride % 4) {
        stride = "query.light_stride";
        bytes = q->light_stride;
    }
    if ((q->position_stride && q->position_stride < 12) || q->position_stride % 4) {
        stride = "query.position_stride";
        bytes = q->position_stride;
    }
    if (!stride) return cohsm__check_light_kind(m, q, log);
    cohsm__log_value(log, stride, (double)bytes, "0, or a multiple of 4 with room for one element");
    return COHSM_ERR_ARGUMENT;
}

static size_t cohsm__count_refused(const float *visible, size_t count)
{
    size_t i, n = 0;
    for (i = 0; i < count; i++) n += visible[i] == COHSM_REFUSED;
    return n;
}

static void cohsm__run_tiles(const cohsm_maps *maps, const cohsm_query *query, float *visible)
{
    cohsm__tile t;
    size_t begin, i;

    cohsm__tile_start(&t, query, maps, 0);
    for (begin = 0; begin < query->count; begin += t.count) {
        t.count = query->count - begin < COHSM__TILE ? query->count - begin : (size_t)COHSM__TILE;
        for (i = 0; i < t.count; i++) t.id[i] = begin + i;
        cohsm__load_tile(&t, NULL);
        cohsm__run_tile(&t);
        memcpy(visible + begin, t.visible, t.count * sizeof *visible);
    }
}

/* Returns the query with its default filled in: a bias of 0 is one pixel, a negative bias is none. */
static cohsm_query cohsm__complete_query(const cohsm_query *query)
{
    cohsm_query q = *query;
    if (q.bias == 0.0f) q.bias = 1.0f;
    if (q.bias < 0.0f) q.bias = 0.0f;
    return q;
}

COHSM_DEF cohsm_result cohsm_visible(const cohsm_maps *maps, const cohsm_query *query, float *visible,
                                     size_t *refused)
{
    cohsm_query q;
    cohsm__logger log = cohsm__logger_of_maps(maps, "cohsm_visible");
    cohsm_result result;

    if (!maps) return COHSM_ERR_ARGUMENT;
    if (!query) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "query", "is NULL");
    if (query->count && !visible) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "visible", "is NULL");
    if (query->count) {
        result = cohsm__check_query(maps, query, &log);
        if (result != COHSM_OK) return result;
    }
    q = cohsm__complete_query(query);
    if (!cohsm__run_stream(maps, &q, visible)) cohsm__run_tiles(maps, &q, visible);
    if (refused) *refused = cohsm__count_refused(visible, query->count);
    return COHSM_OK;
}
