/* ---- ism: the renderer ---- */

/* The shading with its defaults, and what shaders read of it. */
static glbk_result glbk__ism_view_of(const glbk_ism_maps *m, const glbk_ism_shading *shading, glbk_ism_shading *s,
                                     glbk_ism_view *view)
{
    memset(s, 0, sizeof *s);
    s->bias = 0.02f;
    s->clamp = 1;
    if (shading) *s = *shading;
    if (!m || !m->vpls.name || s->near_mode > 6 || s->pattern > 8 || (s->pattern & (s->pattern - 1)) ||
        !(s->bias >= 0 && s->bias < 1) ||
        ((s->near_mode == 3 || s->near_mode == 4) && !(s->clamp > 0 && s->clamp < 3e38f)))
        return GLBK_ERR_ARGUMENT;
    if (!s->near_mode) s->near_mode = 6;
    if (!s->pairs_per_pass) s->pairs_per_pass = 1u << 28;
    memset(view, 0, sizeof *view);
    view->size[2] = s->pattern ? s->pattern : 1;
    view->size[3] = (s->no_maps ? 1u : 0u) | (s->irradiance ? 0u : 2u);
    view->values[0] = s->bias;
    view->values[1] = s->clamp;
    return GLBK_OK;
}

static void glbk__ism_bind_maps(glbk_context *ctx, const glbk_ism_maps *m, const glbk_offset *offset)
{
    const glbk_offset at = glbk__offset(offset);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_ism_vpls, &m->vpls);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_ism_atlas, &m->atlas);
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_ism_frame, &m->frame);
}

GLBK_DEF glbk_result glbk_ism_bind(glbk_context *ctx, const glbk_ism_maps *m, const glbk_ism_shading *shading,
                                   const glbk_offset *offset)
{
    glbk_ism_shading s;
    glbk_ism_view view;
    glbk_result result = ctx ? glbk__ism_view_of(m, shading, &s, &view) : GLBK_ERR_ARGUMENT;
    if (result == GLBK_OK)
        result = glbk__put_block(ctx, glbk__offset(offset).block + GLBK_SLOT_glbk_ism_view, &m->view, &view);
    if (result == GLBK_OK) glbk__ism_bind_maps(ctx, m, offset);
    return result;
}

GLBK_DEF glbk_result glbk_ism_renderer_create(glbk_context *ctx, uint32_t width, uint32_t height,
                                              glbk_ism_renderer *out)
{
    glbk_texture_desc d;
    glbk_target_desc t;
    glbk_result result = GLBK_OK;
    int i;
    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!width || !height) return GLBK_ERR_ARGUMENT;
    memset(&d, 0, sizeof d);
    memset(&t, 0, sizeof t);
    out->width = d.width = width;
    out->height = d.height = height;
    d.format = GLBK_FORMAT_COLOR;
    for (i = 0; i < 4 && result == GLBK_OK; i++) {
        result = glbk_texture_create(ctx, &d, &out->gbuffer[i]);
        t.color[i] = &out->gbuffer[i];
    }
    d.format = GLBK_FORMAT_DEPTH32F;
    t.depth = &out->depth;
    if (result == GLBK_OK) result = glbk_texture_create(ctx, &d, &out->depth);
    if (result == GLBK_OK) result = glbk__target_create(ctx, &t, &out->gbuffer_target);
    if (result == GLBK_OK)
        result = glbk__canvas(ctx, GLBK_FORMAT_COLOR, width, height, NULL, &out->light, &out->light_target);
    if (result == GLBK_OK)
        result = glbk__canvas(ctx, GLBK_FORMAT_COLOR, width, height, NULL, &out->result, &out->result_target);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_ism_view), NULL, &out->view);
    out->compute = ctx->compute;
    if (result == GLBK_OK)
        result = glbk_program_create(ctx, glbk_ism_part(),
                                     out->compute ? "ism_blur.comp" : "ism_blur.frag", NULL, &out->blur);
    if (result == GLBK_OK)
        result = glbk_program_create(ctx, glbk_ism_part(), "ism_resolve.frag", NULL, &out->resolve);
    if (result != GLBK_OK) glbk_ism_renderer_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_ism_renderer_free(glbk_context *ctx, glbk_ism_renderer *r)
{
    int i;
    if (!r) return;
    glbk_target_free(ctx, &r->gbuffer_target);
    glbk_target_free(ctx, &r->light_target);
    glbk_target_free(ctx, &r->result_target);
    for (i = 0; i < 4; i++) glbk_texture_free(ctx, &r->gbuffer[i]);
    glbk_texture_free(ctx, &r->depth);
    glbk_texture_free(ctx, &r->light);
    glbk_texture_free(ctx, &r->result);
    glbk_buffer_free(ctx, &r->view);
    for (i = 0; i < 24; i++) glbk_program_free(ctx, &r->shade[i / 6][i % 6]);
    glbk_program_free(ctx, &r->blur);
    glbk_program_free(ctx, &r->resolve);
    memset(r, 0, sizeof *r);
}

GLBK_DEF glbk_result glbk_ism_gbuffer_upload(glbk_context *ctx, glbk_ism_renderer *r, const glbk_ism_receivers *from)
{
    const float *arrays[4];
    glbk_ism__allocator memory;
    glbk_result result = GLBK_OK;
    size_t count, i, stride;
    float *texels;
    int k;
    if (!ctx || !r || !r->view.name || !from || !from->positions || !from->normals ||
        !glbk_ism__stride_valid(from->stride, 12))
        return GLBK_ERR_ARGUMENT;
    arrays[0] = from->positions;
    arrays[1] = from->normals;
    arrays[2] = from->geometric ? from->geometric : from->normals;
    arrays[3] = from->albedos;
    stride = from->stride ? from->stride : 12;
    count = (size_t)r->width * r->height;
    memory = glbk_ism__memory(ctx);
    texels = (float *)glbk_ism__alloc_array(&memory, count, 16);
    if (!texels) return GLBK_ERR_ALLOC;
    for (k = 0; k < 4 && result == GLBK_OK; k++) {
        for (i = 0; i < count; i++) {
            texels[4 * i] = texels[4 * i + 1] = texels[4 * i + 2] = texels[4 * i + 3] = 1;
            if (arrays[k]) memcpy(texels + 4 * i, (const char *)arrays[k] + stride * i, 12);
        }
        result = glbk_texture_update(ctx, &r->gbuffer[k], 0, 0, 0, 0, r->width, r->height, 1, texels);
    }
    glbk_ism__free(&memory, texels);
    return result;
}

/* Rows of pixels from one on by one program, which reads the G-buffer, the maps and, for the blur, the light: by
 * 16 x 16 of each class of pixels, `side` apart, in groups of the compute path. */
static glbk_result glbk__ism_shade_pass(glbk_context *ctx, const glbk_ism_renderer *r, const glbk_ism_maps *m,
                                        glbk_program *program, int blur, uint32_t side, uint32_t from, uint32_t rows)
{
    glbk_pass pass;
    glbk_result result = GLBK_OK;
    uint32_t i, square = 16 * side;
    memset(&pass, 0, sizeof pass);
    pass.target = blur ? &r->result_target : &r->light_target;
    pass.viewport[1] = (int32_t)from;
    pass.viewport[2] = (int32_t)r->width;
    pass.viewport[3] = (int32_t)rows;
    if (!r->compute) result = glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    for (i = 0; i < 4; i++) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_place + i, &r->gbuffer[i]);
    if (blur) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_light, &r->light);
    else glbk__ism_bind_maps(ctx, m, NULL);
    if (!r->compute) {
        glbk_draw_screen(ctx);
        return GLBK_OK;
    }
    glbk_bind_image(ctx, GLBK_SLOT_glbk_ism_light_out, blur ? &r->result : &r->light);
    return glbk_dispatch(ctx, program, (r->width + square - 1) / square, (rows + square - 1) / square, side * side);
}

/* All pixels in the light of all VPLs, so many rows at a time as have `pairs` of them; whole squares of the compute
   path. */
static glbk_result glbk__ism_shade_all(glbk_context *ctx, const glbk_ism_renderer *r, const glbk_ism_maps *m,
                                       glbk_program *program, glbk_ism_view *view, uint32_t pairs)
{
    const uint32_t side = view->size[2], square = 16 * side;
    const uint64_t row = (uint64_t)r->width * (m->count / (side * side) + 1);
    uint64_t step = pairs / row / square * square;
    glbk_result result = GLBK_OK;
    uint32_t from = 0, rows;
    if (step < square) step = square;
    for (; from < r->height && result == GLBK_OK; from += rows) {
        rows = r->height - from < step ? r->height - from : (uint32_t)step;
        view->values[2] = (float)from;
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_ism_view, &r->view, view);
        if (result == GLBK_OK) result = glbk__ism_shade_pass(ctx, r, m, program, 0, side, from, rows);
    }
    return result;
}

GLBK_DEF glbk_result glbk_ism_shade(glbk_context *ctx, glbk_ism_renderer *r, const glbk_ism_maps *m,
                                    const glbk_ism_shading *shading)
{
    char defines[] = "ISM_PROJECTION=1 ISM_NEAR=1";
    glbk_program *program;
    glbk_ism_shading s;
    glbk_ism_view view;
    glbk_result result = glbk__ism_view_of(m, shading, &s, &view);
    if (result != GLBK_OK || !ctx || !r || !r->view.name) return GLBK_ERR_ARGUMENT;
    defines[15] = (char)('0' + (int)m->desc.projection);
    defines[26] = (char)('0' + (int)s.near_mode);
    program = &r->shade[m->desc.projection - 1][s.near_mode - 1];
    if (!program->name)
        result = glbk_program_create(ctx, glbk_ism_part(),
                                     r->compute ? "ism_shade.comp" : "ism_shade.frag", defines, program);
    view.size[0] = r->width;
    view.size[1] = r->height;
    if (result == GLBK_OK) result = glbk__ism_shade_all(ctx, r, m, program, &view, s.pairs_per_pass);
    return result == GLBK_OK ? glbk__ism_shade_pass(ctx, r, m, &r->blur, 1, 1, 0, r->height) : result;
}

GLBK_DEF glbk_result glbk_ism_resolve(glbk_context *ctx, glbk_ism_renderer *r, const glbk_pass *pass,
                                      const glbk_picture *picture)
{
    glbk_result result;
    int i;
    if (!ctx || !r || !r->resolve.name || !pass) return GLBK_ERR_ARGUMENT;
    result = glbk__begin_picture(ctx, pass, picture, r->width, r->height, &r->resolve);
    if (result != GLBK_OK) return result;
    for (i = 0; i < 3; i++) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_place + (uint32_t)i, &r->gbuffer[i]);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_light, &r->result);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_ism_read_light(glbk_context *ctx, const glbk_ism_renderer *r, float *rgb)
{
    glbk_ism__allocator memory;
    float *texels;
    size_t i, count;
    glbk_result result;
    if (!ctx || !r || !r->view.name || !rgb) return GLBK_ERR_ARGUMENT;
    count = (size_t)r->width * r->height;
    memory = glbk_ism__memory(ctx);
    texels = (float *)glbk_ism__alloc_array(&memory, count, 16);
    if (!texels) return GLBK_ERR_ALLOC;
    result = glbk_target_read(ctx, &r->result_target, 0, 0, 0, r->width, r->height, texels);
    for (i = 0; i < count && result == GLBK_OK; i++) memcpy(rgb + 3 * i, texels + 4 * i, 12);
    glbk_ism__free(&memory, texels);
    return result;
}
