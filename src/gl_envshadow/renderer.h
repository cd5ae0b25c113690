/* ---- envsh: the renderer: light of all maps, summed up pixel by pixel ---- */

GLBK_DEF glbk_result glbk_envsh_renderer_create(glbk_context *ctx, const glbk_envsh_renderer_desc *d,
                                                glbk_envsh_renderer *out)
{
    glbk_result result;

    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "desc", d);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "desc.width", d->width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "desc.height", d->height);
    if (result != GLBK_OK) return result;
    out->width = d->width;
    out->height = d->height;
    out->compute = ctx->compute;
    result = glbk__sums_create(ctx, out->compute, d->width, d->height, out->sums, out->targets);
    if (result == GLBK_OK)
        result = glbk__gbuffer_program(ctx, glbk_envsh_part(), "envsh_resolve.frag", NULL, &out->resolve);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_object), NULL, &out->object);
    if (result != GLBK_OK) glbk_envsh_renderer_free(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_envsh_renderer_resize(glbk_context *ctx, glbk_envsh_renderer *r, uint32_t width,
                                                uint32_t height)
{
    glbk_result result =
        glbk__require_created(ctx, __func__, "renderer", r ? &r->targets[0].name : NULL);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "width", width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "height", height);
    if (result != GLBK_OK) return result;
    glbk__sums_free(ctx, r->sums, r->targets);
    r->begun = 0;
    r->width = width;
    r->height = height;
    result = glbk__sums_create(ctx, r->compute, width, height, r->sums, r->targets);
    if (result != GLBK_OK) glbk_envsh_renderer_free(ctx, r);
    return result;
}

GLBK_DEF void glbk_envsh_renderer_free(glbk_context *ctx, glbk_envsh_renderer *r)
{
    uint32_t i;
    if (!r) return;
    for (i = 0; i < 2 * ENVSH_FILTER_COUNT; i++) glbk_program_free(ctx, &r->shade[i]);
    glbk_program_free(ctx, &r->resolve);
    glbk__sums_free(ctx, r->sums, r->targets);
    glbk_buffer_free(ctx, &r->object);
    memset(r, 0, sizeof *r);
}

/* Checks that a renderer and a G-buffer were created, and for pictures of one size. */
static glbk_result glbk__envsh_fits(const glbk_context *ctx, const char *function,
                                    const glbk_envsh_renderer *r, const glbk_gbuffer *g)
{
    const glbk_result result =
        glbk__require_created(ctx, function, "renderer", r ? &r->targets[0].name : NULL);
    return result == GLBK_OK ? glbk__require_gbuffer(ctx, function, g, r->width, r->height) : result;
}

/* Finds the program of a filter, which is compiled when it is first asked for. */
static glbk_result glbk__envsh_shade_program(glbk_context *ctx, glbk_envsh_renderer *r, uint32_t filter,
                                             uint32_t rgba, glbk_program **out)
{
    char defines[] = "ENVSH_FILTER=0 ENVSH_RGBA=0";
    *out = &r->shade[2 * filter + rgba];
    if ((*out)->name) return GLBK_OK;
    defines[13] = (char)('0' + filter);
    defines[26] = (char)('0' + rgba);
    return glbk__gbuffer_program(ctx, glbk_envsh_part(), r->compute ? "envsh_shade.comp" : "envsh_shade.frag",
                                 defines, *out);
}

/* Adds the light of the lights that m->query names. */
static glbk_result glbk__envsh_shade_pass(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_gbuffer *g,
                                          const glbk_envsh_maps *m, glbk_program *program)
{
    glbk_result result;
    glbk_pass pass;

    memset(&pass, 0, sizeof pass);
    pass.target = &r->targets[!r->now];
    result = r->compute ? GLBK_OK : glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    glbk__envsh_bind_all(ctx, m, NULL);
    (void)glbk_gbuffer_bind(ctx, g, NULL);
    if (r->compute) {
        glbk_bind_image(ctx, GLBK_SLOT_glbk_envsh_total, &r->sums[0]);
        result = glbk_dispatch(ctx, program, (r->width + 7) / 8, (r->height + 7) / 8, 1);
    } else {
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_sum, &r->sums[r->now]);
        glbk_draw_screen(ctx);
        r->now = !r->now;
    }
    if (result == GLBK_OK) r->begun = 1;
    return result;
}

/* Adds the light of all maps, by a query that has its defaults, in as many passes as it takes. */
static glbk_result glbk__envsh_shade_all(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_gbuffer *g,
                                         glbk_envsh_maps *m, const envsh_query *q, uint32_t lights_per_pass)
{
    glbk_envsh_query values;
    glbk_program *program;
    glbk_result result =
        glbk__envsh_shade_program(ctx, r, (uint32_t)q->filter, m->channel_count == 4, &program);
    uint32_t from = 0;

    if (result != GLBK_OK) return result;
    if (!q->add) r->begun = 0;
    if (!lights_per_pass) lights_per_pass = ENVSH_MAX_LIGHTS;
    glbk__envsh_fill_query(q, &values);
    for (; from < m->count && result == GLBK_OK; from = values.end_light) {
        values.first_light = from;
        values.end_light = m->count - from < lights_per_pass ? m->count : from + lights_per_pass;
        values.adds = r->begun != 0;
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_query, &m->query, &values);
        if (result == GLBK_OK) result = glbk__envsh_shade_pass(ctx, r, g, m, program);
    }
    return result;
}

GLBK_DEF glbk_result glbk_envsh_shade(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_gbuffer *g,
                                      glbk_envsh_maps *m, const envsh_query *query, uint32_t lights_per_pass)
{
    envsh_query q;
    glbk_result result = glbk__envsh_fits(ctx, __func__, r, g);
    if (result == GLBK_OK) result = glbk__require_created(ctx, __func__, "maps", m ? &m->query.name : NULL);
    if (result == GLBK_OK) result = glbk__envsh_query_of(ctx, __func__, query, &q);
    return result == GLBK_OK ? glbk__envsh_shade_all(ctx, r, g, m, &q, lights_per_pass) : result;
}

GLBK_DEF glbk_result glbk_envsh_illuminate(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_gbuffer *g,
                                           glbk_envsh_maps *m, const glbk_envsh_frame *f)
{
    envsh_query q;
    uint32_t first = 0, n;
    glbk_result result = glbk__envsh_fits(ctx, __func__, r, g);
    if (result == GLBK_OK) result = glbk__require_created(ctx, __func__, "maps", m ? &m->query.name : NULL);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "frame", f);
    if (result == GLBK_OK && f->view_count) result = glbk__require(ctx, __func__, "frame.views", f->views);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "frame.draw_fn", f->draw_fn ? f : NULL);
    if (result == GLBK_OK) result = glbk__envsh_query_of(ctx, __func__, f->query, &q);
    if (result != GLBK_OK) return result;
    do {
        n = f->view_count - first < m->capacity ? f->view_count - first : m->capacity;
        q.add = first != 0;
        result = glbk_envsh_maps_render(ctx, m, n ? f->views + first : NULL, n, f->draw_fn, f->user);
        if (result == GLBK_OK) result = glbk__envsh_shade_all(ctx, r, g, m, &q, 0);
        first += n;
    } while (first < f->view_count && result == GLBK_OK);
    return result;
}

GLBK_DEF glbk_result glbk_envsh_resolve(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_gbuffer *g,
                                        const glbk_pass *pass, const glbk_picture *picture)
{
    glbk_envsh_object object;
    glbk_result result = glbk__envsh_fits(ctx, __func__, r, g);

    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "pass", pass);
    if (result != GLBK_OK) return result;
    memset(&object, 0, sizeof object);
    object.lit = r->begun != 0;
    result = glbk__begin_picture(ctx, __func__, pass, picture, r->width, r->height, &r->resolve);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_object, &r->object, &object);
    if (result != GLBK_OK) return result;
    (void)glbk_gbuffer_bind(ctx, g, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_sum, &r->sums[r->now]);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_envsh_read(glbk_context *ctx, glbk_envsh_renderer *r, float *rgba)
{
    glbk_result result = glbk__require_created(ctx, __func__, "renderer", r ? &r->targets[0].name : NULL);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "rgba", rgba);
    if (result != GLBK_OK) return result;
    if (r->begun) return glbk_target_read(ctx, &r->targets[r->now], 0, 0, 0, r->width, r->height, rgba);
    memset(rgba, 0, 16 * (size_t)r->width * r->height);
    return GLBK_OK;
}
