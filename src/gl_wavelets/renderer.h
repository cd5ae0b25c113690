/* ---- wavelets: the renderer, and self-visibility of its pixels ---- */

enum {
    GLBK__HAAR_SLOTS = 16,            /* places of a list */
    GLBK__HAAR_WIDE = 2048            /* texels a side of a texture, at most */
};

/* Makes a texture of so many texels. */
static glbk_result glbk__haar_texture(glbk_context *ctx, glbk_format format, uint32_t width,
                                      uint32_t height, uint32_t layers, glbk_texture *out)
{
    glbk_texture_desc d;
    memset(&d, 0, sizeof d);
    d.format = format;
    d.width = width;
    d.height = height;
    d.layers = layers;
    return glbk_texture_create(ctx, &d, out);
}

/* Chooses how many points a batch has, and how many cubes stand in a row: textures have at most so many
   texels a side. */
static void glbk__haar_fit(const glbk_context *ctx, uint32_t wanted, glbk_sfield_haar *h)
{
    const uint32_t side = ctx->max_side < GLBK__HAAR_WIDE ? ctx->max_side : (uint32_t)GLBK__HAAR_WIDE;
    const uint32_t half = h->cube_side / 2, pixels = h->width * h->height;
    uint32_t most;
    h->columns = side / (6 * half);
    most = side / half * h->columns / GLBK__HAAR_SLOTS;
    most = most < side && !h->compute ? most : side;
    if (!wanted) wanted = h->compute && !h->has_gloss ? most : 256;
    h->batch = wanted < most ? wanted : most;
    if (pixels < h->batch) h->batch = pixels;
}

/* Makes the picture of light and, if it is wanted, of gloss. */
static glbk_result glbk__haar_picture(glbk_context *ctx, glbk_sfield_haar *h)
{
    glbk_target_desc target;
    glbk_result result = glbk__haar_texture(ctx, GLBK_FORMAT_COLOR, h->width, h->height, 0, &h->light);
    memset(&target, 0, sizeof target);
    target.color[0] = &h->light;
    if (h->has_gloss && result == GLBK_OK) {
        result = glbk__haar_texture(ctx, GLBK_FORMAT_COLOR, h->width, h->height, 0, &h->gloss);
        target.color[1] = &h->gloss;
    }
    return result == GLBK_OK ? glbk__target_create(ctx, &target, &h->target) : result;
}

/* Makes the textures and targets of a batch. */
static glbk_result glbk__haar_textures(glbk_context *ctx, glbk_sfield_haar *h)
{
    const glbk_format format = GLBK_FORMAT_RGBA32UI;
    const uint32_t half = h->cube_side / 2, wide = h->columns * 6 * half;
    const uint32_t rows = (h->batch * GLBK__HAAR_SLOTS + h->columns - 1) / h->columns,
                   strips = (h->batch + 2 * h->columns - 1) / (2 * h->columns);
    const int sums = h->has_gloss ? 4 : 3;
    glbk_target_desc target;
    glbk_result result = glbk__haar_picture(ctx, h);
    int i, k;
    for (i = 0; i < 3 && result == GLBK_OK; i++)
        result = glbk__haar_texture(ctx, format, GLBK__HAAR_SLOTS, h->batch, 0, &h->list[i]);
    if (result == GLBK_OK)
        result = glbk__canvas(ctx, format, wide, rows * half, NULL, &h->cubes, &h->cubes_target);
    for (i = 0; i < 2 && result == GLBK_OK; i++) {
        memset(&target, 0, sizeof target);
        result = glbk__haar_texture(ctx, format, GLBK__HAAR_SLOTS, h->batch, 0, &h->met[i]);
        for (k = 0; k < 3; k++) target.color[k] = &h->list[k];
        target.color[3] = &h->met[i];
        if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &h->list_target[i]);
        memset(&target, 0, sizeof target);
        for (k = 0; k < sums && result == GLBK_OK; k++) {
            result = glbk__haar_texture(ctx, format, wide, strips * half, 0, &h->left[i][k]);
            target.color[k] = &h->left[i][k];
        }
        if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &h->left_target[i]);
    }
    return result;
}

/* Compiles a program of this header, which uses files of gl_shadowfield.h and gl_gbuffer.h. */
static glbk_result glbk__haar_program(glbk_context *ctx, const char *name, const char *defines,
                                      glbk_program *out)
{
    return glbk__gbuffer_program_above(ctx, &glbk__haar_part, glbk__sfield_reader(), name, defines, out);
}

/* Makes what the compute shader needs: the picture and a buffer for T, where shared memory has no room for
   it, and for the kernels of BRDFs. */
static glbk_result glbk__haar_compute(glbk_context *ctx, glbk_sfield_haar *h)
{
    char defines[] = "SFIELD_BANDS=1 SFIELD_GLOSS=0 SFIELD_SIDE=..";
    const size_t planes = (h->cube_side > 16 ? 1u : 0u) + (h->has_gloss ? 3u : 0u);
    const size_t bytes = planes * 24 * h->cube_side * h->cube_side * h->batch;
    glbk_result result = glbk__haar_picture(ctx, h);
    defines[28] = h->has_gloss ? '1' : '0';
    defines[42] = (char)('0' + (h->cube_side < 10 ? h->cube_side : h->cube_side / 10));
    defines[43] = (char)(h->cube_side < 10 ? 0 : '0' + h->cube_side % 10);
    if (result == GLBK_OK && planes) result = glbk_buffer_create(ctx, bytes, NULL, &h->kept);
    return result == GLBK_OK ? glbk__haar_program(ctx, "sfield_haar_shade.comp", defines, &h->shade) : result;
}

/* Makes what fragment shaders need. */
static glbk_result glbk__haar_fragments(glbk_context *ctx, glbk_sfield_haar *h)
{
    const char *gloss = h->has_gloss ? "SFIELD_GLOSS=1" : "SFIELD_GLOSS=0";
    glbk_result result = glbk__haar_textures(ctx, h);
    if (result == GLBK_OK)
        result = glbk__haar_program(ctx, "sfield_haar_list.frag", "SFIELD_BANDS=1", &h->find);
    if (result == GLBK_OK) result = glbk__haar_program(ctx, "sfield_haar_cubes.frag", gloss, &h->write);
    if (result == GLBK_OK) result = glbk__haar_program(ctx, "sfield_haar_light.frag", gloss, &h->multiply);
    if (result == GLBK_OK) result = glbk__haar_program(ctx, "sfield_haar_sum.frag", gloss, &h->sum);
    return result;
}

static glbk_result glbk__haar_check_desc(const glbk_context *ctx, const char *function,
                                         const glbk_sfield_haar_desc *d)
{
    const uint32_t side = d ? d->cube_side : 0;
    glbk_result result;
    if (!d) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "desc", "is NULL");
    result = glbk__require_side(ctx, function, "desc.width", d->width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, function, "desc.height", d->height);
    if (result != GLBK_OK) return result;
    if (side && (side < 4 || side > 64 || (side & (side - 1))))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.cube_side", side,
                                  "a power of two within 4..64, or 0");
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_sfield_haar_create(glbk_context *ctx, const glbk_sfield_haar_desc *d,
                                             glbk_sfield_haar *out)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    result = glbk__haar_check_desc(ctx, __func__, d);
    if (result != GLBK_OK) return result;
    out->width = d->width;
    out->height = d->height;
    out->cube_side = d->cube_side ? d->cube_side : 32;
    out->has_self = d->self != 0;
    out->has_gloss = d->gloss != 0;
    out->compute = ctx->compute && out->cube_side <= GLBK__HAAR_SHARED;
    glbk__haar_fit(ctx, d->batch, out);
    result = out->compute ? glbk__haar_compute(ctx, out) : glbk__haar_fragments(ctx, out);
    if (result == GLBK_OK && d->self)
        result = glbk__haar_texture(ctx, GLBK_FORMAT_R32UI, out->width, out->height, 1, &out->self);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_haar_batch), NULL, &out->block);
    if (result != GLBK_OK) glbk_sfield_haar_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_sfield_haar_free(glbk_context *ctx, glbk_sfield_haar *h)
{
    int i, k;
    if (!h) return;
    glbk_program_free(ctx, &h->find);
    glbk_program_free(ctx, &h->write);
    glbk_program_free(ctx, &h->multiply);
    glbk_program_free(ctx, &h->sum);
    glbk_program_free(ctx, &h->shade);
    glbk_buffer_free(ctx, &h->kept);
    glbk_target_free(ctx, &h->target);
    glbk_target_free(ctx, &h->cubes_target);
    glbk_texture_free(ctx, &h->light);
    glbk_texture_free(ctx, &h->gloss);
    glbk_texture_free(ctx, &h->self);
    glbk_texture_free(ctx, &h->cubes);
    for (i = 0; i < 3; i++) glbk_texture_free(ctx, &h->list[i]);
    for (i = 0; i < 2; i++) {
        glbk_target_free(ctx, &h->list_target[i]);
        glbk_target_free(ctx, &h->left_target[i]);
        glbk_texture_free(ctx, &h->met[i]);
        for (k = 0; k < 4; k++) glbk_texture_free(ctx, &h->left[i][k]);
    }
    glbk_buffer_free(ctx, &h->block);
    memset(h, 0, sizeof *h);
}

/* Checks a renderer and a scene of wavelets, which belong together. */
static glbk_result glbk__haar_check_pair(const glbk_context *ctx, const char *function,
                                         const glbk_sfield_haar *h, const glbk_sfield_scene *s)
{
    glbk_result result;
    if (!h || !h->block.name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "haar", h ? "was not created" : "is NULL");
    result = glbk__sfield_check_scene(ctx, function, s);
    if (result != GLBK_OK) return result;
    if (s->cube_side == h->cube_side && !s->lists == !h->compute) return GLBK_OK;
    if (!s->cube_side) return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "scene", "has harmonics");
    if (s->cube_side == h->cube_side)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "scene",
                            "was uploaded with another ctx->compute than the renderer was made with");
    return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "scene->cube_side", s->cube_side,
                              "that of the renderer");
}

/* Writes where the trees of a point's self-visibility begin, 0 for none. */
static glbk_result glbk__haar_root(const glbk_context *ctx, const char *function,
                                   const glbk_sfield_scene *s, const glbk_sfield_own *own,
                                   size_t index, uint32_t *root)
{
    const glbk_sfield_field *field = glbk__sfield_find(s, own->self);
    char name[GLBK__ELEMENT_ROOM];
    sfield_info info;
    *root = 0;
    if (!own->self) return GLBK_OK;
    if (!field || field->source != GLBK__HAAR_IS_SELF)
        return glbk__refuse_element(ctx, GLBK_ERR_MISMATCH, function, "own", index, ".self",
                                    "is none of the scene's self-visibilities");
    sfield_get_info(own->self, &info);
    if (own->point >= info.sample_count) {
        glbk__name_element(name, "own", index, ".point");
        return glbk__refuse_range(ctx, GLBK_ERR_INPUT, function, name, own->point, 0,
                                  (double)info.sample_count - 1);
    }
    *root = field->start + 3 + (s->lists ? 1 : 6) * own->point;
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_sfield_haar_self(glbk_context *ctx, glbk_sfield_haar *h, const glbk_sfield_scene *s,
                                           uint32_t row, uint32_t row_count, const glbk_sfield_own *own)
{
    glbk_box box = { 0, 0, 0, 0, 0, 0, 1 };
    glbk_haar__allocator memory;
    glbk_result result;
    uint32_t *roots;
    size_t i, count;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__haar_check_pair(ctx, __func__, h, s);
    if (result != GLBK_OK) return result;
    if (!h->has_self)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "haar", "was created without desc.self");
    if (!own) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "own", "is NULL");
    result = glbk__sfield_check_rows(ctx, __func__, h->height, row, row_count);
    if (result != GLBK_OK) return result;
    memory = glbk_haar__memory(ctx);
    count = (size_t)h->width * row_count;
    roots = (uint32_t *)glbk_haar__alloc_array(&memory, count, 4);
    if (!roots) return GLBK_ERR_ALLOC;
    for (i = 0; i < count && result == GLBK_OK; i++)
        result = glbk__haar_root(ctx, __func__, s, &own[i], i, &roots[i]);
    box.y = row;
    box.width = h->width;
    box.height = row_count;
    if (result == GLBK_OK && h->self_of != s->key) result = glbk__sfield_blank(ctx, &h->self);
    if (result == GLBK_OK) h->self_of = s->key;
    if (result == GLBK_OK) result = glbk_texture_update(ctx, &h->self, &box, roots);
    glbk_haar__free(&memory, roots);
    return result;
}
