/* ---- shade: all lights at many points ---- */

#define ENVSH__BATCH 256u           /* points of a task */
#define ENVSH__ALL UINT32_MAX       /* in place of the number of one light */

typedef struct envsh__shading {
    const envsh_maps  *maps;
    const envsh_query *query;       /* with its defaults filled in */
    const envsh_points *points;
    float    *out;                  /* the visibility of one light, or the irradiance of all */
    uint32_t  only;                 /* the number of that one light, or ENVSH__ALL */
    float     disc[2 * ENVSH_MAX_TAPS];     /* taps on the unit disc */
} envsh__shading;

/* Adds one light to a batch of points. Lights come one after the other, not points, so that the texels of a
   tile are used while they are in the cache. */
static void envsh__shade_light(const envsh__shading *s, uint32_t light, size_t begin, size_t end)
{
    const envsh_maps *m = s->maps;
    const envsh_points *r = s->points;
    const envsh_view *v = &m->views[light];
    envsh__v3 d = envsh__v3_load(v->direction);
    envsh__lookup l;
    size_t i;
    int c;
    l.view = v;
    l.tile = envsh__tile_texels(m, light, &l.row);
    l.cells = m->bounds + 2 * (size_t)light * m->cells * m->cells;
    l.step = m->channels;
    l.size = (int32_t)m->map_side;
    l.cells_wide = (int32_t)m->cells;
    l.query = s->query;
    l.first = r->first;
    l.disc = s->disc;
    for (i = begin; i < end; i++) {
        envsh__v3 p = envsh__load_item(r->positions, r->position_stride, i);
        envsh__v3 n = envsh__load_item(r->normals, r->normal_stride, i);
        envsh__v3 flat = r->geometric_normals
                         ? envsh__load_item(r->geometric_normals, r->geometric_normal_stride, i) : n;
        float cosine = envsh__v3_dot(n, d), side = r->geometric_normals ? envsh__v3_dot(flat, d) : cosine;
        float visible;
        if (s->only != ENVSH__ALL) {
            s->out[i] = side > 0.0f &&
                        envsh__v3_finite(p) ? envsh__find_visibility(&l, p, flat, side, (uint32_t)i) : 0.0f;
            continue;
        }
        if (!(cosine > 0.0f) || !(side > 0.0f) || !envsh__finite(cosine) || !envsh__v3_finite(p)) continue;
        visible = envsh__find_visibility(&l, p, flat, side, (uint32_t)i) * cosine;
        for (c = 0; c < 3; c++) s->out[3 * i + (size_t)c] += visible * v->irradiance[c];
    }
}

/* Shades a batch of points. */
static void envsh__shade_task(void *context, size_t batch)
{
    const envsh__shading *s = (const envsh__shading *)context;
    size_t begin = batch * ENVSH__BATCH, end = begin + ENVSH__BATCH, i;
    uint32_t light;
    if (end > s->points->count) end = s->points->count;
    if (s->only != ENVSH__ALL) {
        envsh__shade_light(s, s->only, begin, end);
        return;
    }
    for (i = 3 * begin; !s->query->add && i < 3 * end; i++) s->out[i] = 0.0f;
    for (light = 0; light < s->maps->count; light++) envsh__shade_light(s, light, begin, end);
}

/* Returns the number of the first normal that is finite but neither unit nor 0 0 0, or count if there is
   none. */
static size_t envsh__find_bad_normal(const float *normals, size_t stride, size_t count)
{
    size_t i;
    for (i = 0; normals && i < count; i++) {
        envsh__v3 n = envsh__load_item(normals, stride, i);
        if (!envsh__is_unit(n) && envsh__v3_finite(n) && (n.x != 0.0f || n.y != 0.0f || n.z != 0.0f))
            return i;
    }
    return count;
}

/* Checks the lengths of normals, which may be NULL. */
static envsh_result envsh__check_normals(const char *field, const float *normals, size_t stride, size_t count,
                                         const envsh__logger *log)
{
    size_t i = envsh__find_bad_normal(normals, stride, count);
    if (i == count) return ENVSH_OK;
    envsh__log_element(log, field, i, "has the length",
                       (double)envsh__v3_length(envsh__load_item(normals, stride, i)),
                       "1 (0.97..1.03), or 0");
    return ENVSH_ERR_INPUT;
}

/* Checks points and the output, whose name is for the log. */
static envsh_result envsh__check_points(const envsh_points *p, const void *out, const char *name,
                                        const envsh__logger *log)
{
    const envsh_result bad = ENVSH_ERR_ARGUMENT;
    envsh_result result;
    if (!p) return envsh__refuse_text(log, "points", "is NULL", bad);
    if (!envsh__stride_fits(p->position_stride))
        return envsh__refuse_stride(log, "points.position_stride", p->position_stride);
    if (!envsh__stride_fits(p->normal_stride))
        return envsh__refuse_stride(log, "points.normal_stride", p->normal_stride);
    if (!envsh__stride_fits(p->geometric_normal_stride))
        return envsh__refuse_stride(log, "points.geometric_normal_stride", p->geometric_normal_stride);
    if (!p->count) return ENVSH_OK;
    if (!p->positions) return envsh__refuse_text(log, "points.positions", "is NULL", bad);
    if (!p->normals) return envsh__refuse_text(log, "points.normals", "is NULL", bad);
    if (!out) return envsh__refuse_text(log, name, "is NULL", bad);
    result = envsh__check_normals("points.normals", p->normals, p->normal_stride, p->count, log);
    if (result != ENVSH_OK) return result;
    return envsh__check_normals("points.geometric_normals", p->geometric_normals, p->geometric_normal_stride,
                                p->count, log);
}

/* Shades points by a query whose defaults are filled in. Both have been checked. */
static envsh_result envsh__run_shading(const envsh_maps *m, const envsh_query *q, const envsh_points *points,
                                       float *out, uint32_t only)
{
    envsh__shading s;
    size_t batches = points->count / ENVSH__BATCH + (points->count % ENVSH__BATCH != 0);
    s.maps = m;
    s.query = q;
    s.points = points;
    s.out = out;
    s.only = only;
    envsh__fill_disc(s.disc, q->tap_count <= ENVSH_MAX_TAPS ? q->tap_count : 1);
    return envsh__run_steps(m, batches, envsh__shade_task, &s);
}

/* Checks whether maps can be shaded with: they have texels, and envsh_maps_end came after the last change. */
static envsh_result envsh__check_finished(const envsh_maps *m, const envsh__logger *log)
{
    if (m->no_depth) return envsh__refuse_no_depth(log);
    if (m->phase != 2) return envsh__refuse_text(log, "envsh_maps_end", "must come first", ENVSH_ERR_ORDER);
    return ENVSH_OK;
}

ENVSH_DEF envsh_result envsh_shade(const envsh_maps *maps, const envsh_query *query,
                                   const envsh_points *points, float *irradiance)
{
    envsh__logger logger;
    envsh_query q;
    envsh_result result;
    if (!maps) return ENVSH_ERR_ARGUMENT;
    logger = envsh__make_logger(&maps->system, "envsh_shade");
    result = envsh__check_query(query, &q, &logger);
    if (result == ENVSH_OK) result = envsh__check_points(points, irradiance, "irradiance", &logger);
    if (result == ENVSH_OK) result = envsh__check_finished(maps, &logger);
    return result == ENVSH_OK ? envsh__run_shading(maps, &q, points, irradiance, ENVSH__ALL) : result;
}

ENVSH_DEF envsh_result envsh_visible(const envsh_maps *maps, uint32_t light, const envsh_query *query,
                                     const envsh_points *points, float *visible)
{
    envsh__logger logger;
    envsh_query q;
    envsh_result result;
    if (!maps) return ENVSH_ERR_ARGUMENT;
    logger = envsh__make_logger(&maps->system, "envsh_visible");
    result = envsh__check_query(query, &q, &logger);
    if (result == ENVSH_OK) result = envsh__check_points(points, visible, "visible", &logger);
    if (result == ENVSH_OK) result = envsh__check_finished(maps, &logger);
    if (result == ENVSH_OK && light >= maps->count) result = envsh__refuse_light(&logger, light, maps->count);
    return result == ENVSH_OK ? envsh__run_shading(maps, &q, points, visible, light) : result;
}

ENVSH_DEF float envsh_visibility_twin(const envsh_tile *tile, const envsh_query *query, const float point[3],
                                      const float geometric_normal[3], uint32_t index)
{
    static const envsh__logger silent = { NULL, NULL, "envsh_visibility_twin" };
    float disc[2 * ENVSH_MAX_TAPS], cosine;
    envsh_query q;
    envsh__v3 n;
    envsh__lookup l;
    if (!tile || !tile->view || !tile->depth || !point || !geometric_normal) return 0.0f;
    if (envsh__check_query(query, &q, &silent) != ENVSH_OK) return 0.0f;
    n = envsh__v3_load(geometric_normal);
    if (!envsh__is_unit(n)) return 0.0f;
    memset(&l, 0, sizeof l);
    envsh__fill_disc(disc, q.tap_count <= ENVSH_MAX_TAPS ? q.tap_count : 1);
    l.view = tile->view;
    l.tile = tile->depth;
    l.row = tile->row_stride / 4;
    l.step = tile->texel_stride / 4;
    l.size = (int32_t)tile->side;
    l.query = &q;
    l.disc = disc;
    cosine = envsh__v3_dot(n, envsh__v3_load(tile->view->direction));
    return cosine > 0.0f ? envsh__find_visibility(&l, envsh__v3_load(point), n, cosine, index) : 0.0f;
}
