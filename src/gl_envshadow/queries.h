/* ---- envsh: queries: settings checked, and bound with the maps for shaders ---- */

/* Returns what a setting means: 0 if it is negative, the default if it is 0. */
static float glbk__envsh_or_default(float value, float standard)
{
    return value < 0 ? 0.0f : value == 0 ? standard : value;
}

/* Writes a query with its defaults, or says which field is out of range, as envshadow.h's checks do. */
static glbk_result glbk__envsh_query_of(const glbk_context *ctx, const char *function,
                                        const envsh_query *from, envsh_query *q)
{
    static const float most[] = { 0, 0, 8, 32, 64 };     /* the greatest radius of each filter */
    memset(q, 0, sizeof *q);
    if (from) *q = *from;
    if ((unsigned)q->filter >= ENVSH_FILTER_COUNT)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "query.filter", q->filter, 0,
                                  ENVSH_FILTER_COUNT - 1);
    if (q->filter == ENVSH_FILTER_DEFAULT) q->filter = ENVSH_FILTER_PENUMBRA;
    if (!(q->bias <= 1e6f))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "query.bias", (double)q->bias,
                                  "at most 1e6 texels");
    q->bias = glbk__envsh_or_default(q->bias, 1);
    if (!q->tap_count) q->tap_count = 16;
    if (q->filter == ENVSH_FILTER_PLAIN) {
        q->tap_count = 1;
        q->radius = q->extent_scale = 0;
        return GLBK_OK;
    }
    if (!(q->radius <= most[q->filter]) ||
        (q->filter == ENVSH_FILTER_SMOOTH && q->radius < 0.5f && q->radius != 0))
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "query.radius", (double)q->radius,
                                  q->filter == ENVSH_FILTER_SMOOTH ? 0.5 : 0, (double)most[q->filter]);
    q->radius = glbk__envsh_or_default(q->radius, q->filter == ENVSH_FILTER_PENUMBRA ? 12.0f : 2.0f);
    if (q->filter == ENVSH_FILTER_SMOOTH) return GLBK_OK;
    if (q->tap_count > ENVSH_MAX_TAPS)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "query.tap_count", q->tap_count, 0,
                                 ENVSH_MAX_TAPS);
    if (!(q->extent_scale <= 1e6f))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "query.extent_scale", (double)q->extent_scale,
                                  "at most 1e6");
    q->extent_scale = glbk__envsh_or_default(q->extent_scale, 1);
    return GLBK_OK;
}

/* Fills the block of a query. The taps lie on Vogel's spiral, each turned by the golden angle from the one
   before. */
static void glbk__envsh_fill_query(const envsh_query *q, glbk_envsh_query *out)
{
    const double cosine = -0.73736887807831990, sine = 0.67549029426152364;
    double x = 1, y = 0, t;
    uint32_t i;
    memset(out, 0, sizeof *out);
    out->radius = q->radius;
    out->bias = q->bias;
    out->extent_scale = q->extent_scale;
    out->taps = q->tap_count;
    out->seed = q->seed;
    for (i = 0; i < q->tap_count && i < ENVSH_MAX_TAPS; i++) {
        float radius = sqrtf(((float)i + 0.5f) / (float)q->tap_count);
        out->disc[2 * i] = radius * (float)x;
        out->disc[2 * i + 1] = radius * (float)y;
        t = x * cosine - y * sine;
        y = x * sine + y * cosine;
        x = t;
    }
}

/* Binds all that shaders read of maps. */
static void glbk__envsh_bind_all(glbk_context *ctx, const glbk_envsh_maps *m, const glbk_offset *offset)
{
    const glbk_offset at = glbk__offset(offset);
    const uint32_t atlas = m->channel_count == 4 ? GLBK_SLOT_glbk_envsh_depth4 : GLBK_SLOT_glbk_envsh_depth;
    glbk_bind_texture(ctx, at.unit + atlas, &m->atlas);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_envsh_cells, &m->cells);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_envsh_views, &m->views);
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_envsh_scene, &m->scene);
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_envsh_query, &m->query);
}

GLBK_DEF glbk_result glbk_envsh_bind(glbk_context *ctx, glbk_envsh_maps *m, const envsh_query *query,
                                     const glbk_offset *offset)
{
    glbk_envsh_query values;
    envsh_query q;
    glbk_result result = glbk__require_created(ctx, __func__, "maps", m ? &m->query.name : NULL);
    if (result == GLBK_OK) result = glbk__envsh_query_of(ctx, __func__, query, &q);
    if (result != GLBK_OK) return result;
    glbk__envsh_fill_query(&q, &values);
    result = glbk__put_block(ctx, glbk__offset(offset).block + GLBK_SLOT_glbk_envsh_query, &m->query,
                             &values);
    if (result == GLBK_OK) glbk__envsh_bind_all(ctx, m, offset);
    return result;
}
