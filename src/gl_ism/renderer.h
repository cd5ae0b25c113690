/* ---- ism: the renderer: light of all VPLs at the pixels of a G-buffer ---- */

/* Returns the values of the uniform block for a shading, which has its defaults. */
static glbk_ism_view glbk__ism_view_of(const ism_shading *s)
{
    glbk_ism_view view;
    memset(&view, 0, sizeof view);
    view.interleave = s->interleave;
    view.no_maps = s->no_maps != 0;
    view.bias = s->bias;
    view.clamp_at = s->clamp;
    return view;
}

/* Binds the textures and the block that shading reads of maps. */
static void glbk__ism_bind_maps(glbk_context *ctx, const glbk_ism_maps *m, const glbk_offset *offset)
{
    const glbk_offset at = glbk__offset(offset);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_ism_vpls, &m->vpls);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_ism_atlas, &m->atlas);
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_ism_frame, &m->frame);
}

GLBK_DEF glbk_result glbk_ism_bind(glbk_context *ctx, const glbk_ism_maps *m, const ism_shading *shading,
                                   const glbk_offset *offset)
{
    ism_shading s;
    glbk_ism_view view;
    glbk_result result = glbk__ism_check_maps(ctx, __func__, m);
    if (result == GLBK_OK) result = glbk__ism_check_shading(ctx, __func__, shading, &s);
    if (result != GLBK_OK) return result;
    view = glbk__ism_view_of(&s);
    result = glbk__put_block(ctx, glbk__offset(offset).block + GLBK_SLOT_glbk_ism_view, &m->view, &view);
    if (result == GLBK_OK) glbk__ism_bind_maps(ctx, m, offset);
    return result;
}

/* Makes the pictures of a renderer, of a size. */
static void glbk__ism_make_pictures(glbk__ism_making *k, glbk_ism_renderer *r, uint32_t width,
                                    uint32_t height)
{
    r->width = width;
    r->height = height;
    glbk__ism_make_canvas(k, GLBK_FORMAT_COLOR, width, height, NULL, &r->light, &r->light_target);
    glbk__ism_make_canvas(k, GLBK_FORMAT_COLOR, width, height, NULL, &r->result, &r->result_target);
}

GLBK_DEF glbk_result glbk_ism_renderer_create(glbk_context *ctx, const glbk_ism_renderer_desc *d,
                                              glbk_ism_renderer *out)
{
    glbk__ism_making k;
    glbk_result result;
    result = glbk__enter_create(ctx, __func__, out, sizeof *out);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "desc", d);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "desc.width", d->width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "desc.height", d->height);
    if (result != GLBK_OK) return result;
    out->compute = ctx->compute;
    k = glbk__ism_begin_making(ctx);
    glbk__ism_make_pictures(&k, out, d->width, d->height);
    glbk__ism_make_block(&k, sizeof(glbk_ism_view), &out->view);
    glbk__ism_make_program(&k, out->compute ? "ism_blur.comp" : "ism_blur.frag", &out->blur);
    glbk__ism_make_program(&k, "ism_resolve.frag", &out->resolve);
    if (k.result != GLBK_OK) glbk_ism_renderer_free(ctx, out);
    return k.result;
}

static void glbk__ism_free_pictures(glbk_context *ctx, glbk_ism_renderer *r)
{
    glbk_target_free(ctx, &r->light_target);
    glbk_target_free(ctx, &r->result_target);
    glbk_texture_free(ctx, &r->light);
    glbk_texture_free(ctx, &r->result);
}

GLBK_DEF glbk_result glbk_ism_renderer_resize(glbk_context *ctx, glbk_ism_renderer *r, uint32_t width,
                                              uint32_t height)
{
    glbk__ism_making k;
    glbk_result result = glbk__require_created(ctx, __func__, "renderer", r ? &r->result_target.name : NULL);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "width", width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "height", height);
    if (result != GLBK_OK) return result;
    glbk__ism_free_pictures(ctx, r);
    k = glbk__ism_begin_making(ctx);
    glbk__ism_make_pictures(&k, r, width, height);
    if (k.result != GLBK_OK) glbk_ism_renderer_free(ctx, r);
    return k.result;
}

static void glbk__ism_free_shade(glbk_context *ctx, glbk_ism_renderer *r)
{
    int projection, near_mode;
    for (projection = 0; projection < ISM_PROJECTION_COUNT; projection++)
        for (near_mode = 0; near_mode < ISM_NEAR_COUNT; near_mode++)
            glbk_program_free(ctx, &r->shade[projection][near_mode]);
}

GLBK_DEF void glbk_ism_renderer_free(glbk_context *ctx, glbk_ism_renderer *r)
{
    if (!r) return;
    glbk__ism_free_pictures(ctx, r);
    glbk__ism_free_shade(ctx, r);
    glbk_buffer_free(ctx, &r->view);
    glbk_program_free(ctx, &r->blur);
    glbk_program_free(ctx, &r->resolve);
    memset(r, 0, sizeof *r);
}

/* The objects that the passes of a glbk_ism_shade read and write. */
typedef struct glbk__ism_job {
    const glbk_ism_renderer *renderer;
    const glbk_gbuffer      *gbuffer;
    const glbk_ism_maps     *maps;
    glbk_program            *program;
    glbk_ism_view            view;
} glbk__ism_job;

GLBK_DEF glbk_result glbk_ism_renderer_see(glbk_context *ctx, glbk_ism_renderer *r,
                                           const glbk_ism_visible *own)
{
    const glbk_result result = glbk__ism_check_renderer(ctx, __func__, r);
    if (result != GLBK_OK) return result;
    glbk__ism_free_shade(ctx, r);
    memset(&r->own, 0, sizeof r->own);
    if (own && own->text) r->own = *own;    /* without a text bind_fn is not called either */
    return GLBK_OK;
}

/* Returns whether a pass is computed. With a function of the user's, fragments are shaded, so that its
   program is in use before it is drawn with. */
static int glbk__ism_by_compute(const glbk_ism_renderer *r, int blur)
{
    return r->compute && (blur || !r->own.text);
}

/* Finds the program of a projection and of a rule near by, and compiles it at first use. */
static glbk_result glbk__ism_shade_program(glbk_context *ctx, glbk_ism_renderer *r, ism_projection projection,
                                           ism_near near_mode, glbk_program **out)
{
    const char *name = glbk__ism_by_compute(r, 0) ? "ism_shade.comp" : "ism_shade.frag";
    char defines[] = "ISM_PROJECTION=1 ISM_NEAR=1 GLBK_OWN_VISIBLE";
    const char *texts[2] = { NULL, NULL };
    *out = &r->shade[projection][near_mode];
    if ((*out)->name) return GLBK_OK;
    defines[15] = (char)('0' + (int)projection);
    defines[26] = (char)('0' + (int)near_mode);
    texts[1] = r->own.text;
    if (!texts[1]) defines[27] = 0;
    return glbk__gbuffer_program_with(ctx, glbk_ism_part(), name, defines, texts, *out);
}

/* Runs the job's program over `rows` rows of pixels from row `first` on. The program reads the G-buffer and
   either the maps or, if blur is not 0, the light. A group of the compute path has 16 x 16 pixels of one
   class, which lie `side` apart. */
static glbk_result glbk__ism_pixels_pass(glbk_context *ctx, const glbk__ism_job *job, int blur, uint32_t side,
                                         uint32_t first, uint32_t rows)
{
    const glbk_ism_renderer *r = job->renderer;
    const uint32_t square = 16 * side;
    const int compute = glbk__ism_by_compute(r, blur);
    glbk_pass pass;
    glbk_result result = GLBK_OK;
    memset(&pass, 0, sizeof pass);
    pass.target = blur ? &r->result_target : &r->light_target;
    pass.viewport[1] = (int32_t)first;
    pass.viewport[2] = (int32_t)r->width;
    pass.viewport[3] = (int32_t)rows;
    if (!compute) result = glbk_begin(ctx, &pass, job->program);
    if (result != GLBK_OK) return result;
    (void)glbk_gbuffer_bind(ctx, job->gbuffer, NULL);       /* The callers have checked it. */
    if (blur) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_light, &r->light);
    else glbk__ism_bind_maps(ctx, job->maps, NULL);
    if (!blur && r->own.bind_fn) r->own.bind_fn(r->own.user, ctx);
    if (!compute) {
        glbk_draw_screen(ctx);
        return GLBK_OK;
    }
    glbk_bind_image(ctx, GLBK_SLOT_glbk_ism_light_out, blur ? &r->result : &r->light);
    return glbk_dispatch(ctx, job->program, (r->width + square - 1) / square, (rows + square - 1) / square,
                         side * side);
}

/* Lights all pixels by all VPLs. A pass has as many rows as make about `pairs` pairs of a pixel and a VPL, in
   whole squares of the compute path. */
static glbk_result glbk__ism_shade_all(glbk_context *ctx, glbk__ism_job *job, uint32_t pairs)
{
    const glbk_ism_renderer *r = job->renderer;
    const uint32_t side = job->view.interleave, square = 16 * side;
    const uint64_t row = (uint64_t)r->width * (job->maps->vpl_count / (side * side) + 1);
    uint64_t step = (pairs ? pairs : 1u << 28) / row / square * square;
    glbk_result result = GLBK_OK;
    uint32_t first = 0, rows;
    if (step < square) step = square;
    for (; first < r->height && result == GLBK_OK; first += rows) {
        rows = r->height - first < step ? r->height - first : (uint32_t)step;
        job->view.first_row = first;
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_ism_view, &r->view, &job->view);
        if (result == GLBK_OK) result = glbk__ism_pixels_pass(ctx, job, 0, side, first, rows);
    }
    return result;
}

GLBK_DEF glbk_result glbk_ism_shade(glbk_context *ctx, glbk_ism_renderer *r, const glbk_gbuffer *g,
                                    const glbk_ism_maps *m, const ism_shading *shading,
                                    uint32_t pairs_per_pass)
{
    glbk__ism_job job;
    ism_shading s;
    glbk_result result = glbk__ism_check_gbuffer(ctx, __func__, r, g);
    if (result == GLBK_OK) result = glbk__ism_check_maps(ctx, __func__, m);
    if (result == GLBK_OK) result = glbk__ism_check_shading(ctx, __func__, shading, &s);
    if (result != GLBK_OK) return result;
    if (r->own.text) s.no_maps = 0;         /* as ism_shade asks its visible_fn in any case */
    else if (m->vpl_count && !m->drawn && !s.no_maps)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "maps", "must be drawn first: glbk_ism_draw");
    job.renderer = r;
    job.gbuffer = g;
    job.maps = m;
    job.view = glbk__ism_view_of(&s);
    job.view.width = r->width;
    job.view.height = r->height;
    result = glbk__ism_shade_program(ctx, r, m->desc.projection, s.near_mode, &job.program);
    if (result == GLBK_OK) result = glbk__ism_shade_all(ctx, &job, pairs_per_pass);
    if (result != GLBK_OK) return result;
    job.program = &r->blur;
    return glbk__ism_pixels_pass(ctx, &job, 1, 1, 0, r->height);
}

GLBK_DEF glbk_result glbk_ism_resolve(glbk_context *ctx, glbk_ism_renderer *r, const glbk_gbuffer *g,
                                      const glbk_pass *pass, const glbk_picture *picture)
{
    glbk_result result = glbk__ism_check_gbuffer(ctx, __func__, r, g);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "pass", pass);
    if (result != GLBK_OK) return result;
    result = glbk__begin_picture(ctx, __func__, pass, picture, r->width, r->height, &r->resolve);
    if (result != GLBK_OK) return result;
    (void)glbk_gbuffer_bind(ctx, g, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_light, &r->result);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_ism_read(glbk_context *ctx, const glbk_ism_renderer *r, float *rgba)
{
    glbk_result result = glbk__ism_check_renderer(ctx, __func__, r);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "rgba", rgba);
    if (result != GLBK_OK) return result;
    return glbk_target_read(ctx, &r->result_target, 0, 0, 0, r->width, r->height, rgba);
}
