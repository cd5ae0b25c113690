/* ---- rsm: the renderer: pictures, programs and tables that calls of a frame use ---- */

/* Makes pictures of colours, each with its framebuffer. */
static glbk_result glbk__rsm_pictures(glbk_context *ctx, uint32_t count, uint32_t width, uint32_t height,
                                      glbk_texture *textures, glbk_target *targets)
{
    glbk_result result = GLBK_OK;
    uint32_t i;
    for (i = 0; i < count && result == GLBK_OK; i++) {
        result = glbk__rsm_image(ctx, GLBK_FORMAT_COLOR, width, height, 0, &textures[i]);
        if (result == GLBK_OK) result = glbk__rsm_target(ctx, &textures[i], 0, 1, NULL, &targets[i]);
    }
    return result;
}

enum { GLBK__RSM_LISTS = 13 };     /* lists of nodes and of pending pixels for six grids, and one more */

/* Makes the lists of interpolation by compute. */
static glbk_result glbk__rsm_lists(glbk_context *ctx, glbk_rsm_renderer *r)
{
    size_t pixels = (size_t)r->width * r->height, nodes = (size_t)(r->width / 2 + 2) * (r->height / 2 + 2);
    glbk_result result = glbk_buffer_create(ctx, 4 * pixels, NULL, &r->pending[0]);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, 4 * pixels, NULL, &r->pending[1]);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, 4 * nodes, NULL, &r->wanted);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, nodes / 8 + 4, NULL, &r->marks);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, 16 * GLBK__RSM_LISTS, NULL, &r->counts);
    return result;
}

/* Makes history i: the light of each pixel in a frame, with the place and normal that were seen there. */
static glbk_result glbk__rsm_history(glbk_context *ctx, glbk_rsm_renderer *r, uint32_t i)
{
    glbk_target_desc d;
    glbk_result result = glbk__rsm_image(ctx, GLBK_FORMAT_COLOR, r->width, r->height, 0, &r->history[i]);
    if (result == GLBK_OK)
        result = glbk__rsm_image(ctx, GLBK_FORMAT_RGBA32UI, r->width, r->height, 2, &r->kept[i]);
    if (result != GLBK_OK) return result;
    memset(&d, 0, sizeof d);
    d.color[0] = &r->history[i];
    d.color[1] = d.color[2] = &r->kept[i];
    d.layer[2] = 1;
    return glbk_target_create(ctx, &d, &r->history_targets[i]);
}

/* Makes what a renderer has of its size, images and lists, and nothing is in them. */
static glbk_result glbk__rsm_renderer_images(glbk_context *ctx, glbk_rsm_renderer *r, int interpolate,
                                             int denoise)
{
    uint32_t w = r->width, h = r->height, i;
    glbk_result result = glbk__rsm_pictures(ctx, 3, w, h, r->sums, r->targets);
    r->direct = r->bounce = GLBK__RSM_NONE;
    r->remembers = 0;
    r->has_before = r->filtered = 0;
    if (result == GLBK_OK && interpolate)
        result = glbk__rsm_pictures(ctx, r->compute ? 1 : 3, w / 2 + 2, h / 2 + 2, r->grids, r->grid_targets);
    if (result == GLBK_OK && interpolate && r->compute) result = glbk__rsm_lists(ctx, r);
    for (i = 0; i < 2 && denoise && result == GLBK_OK; i++) result = glbk__rsm_history(ctx, r, i);
    return result;
}

GLBK_DEF glbk_result glbk_rsm_renderer_create(glbk_context *ctx, const glbk_rsm_renderer_desc *d,
                                              glbk_rsm_renderer *out)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    if (!d) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "desc", "is NULL");
    result = glbk__require_side(ctx, __func__, "desc.width", d->width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "desc.height", d->height);
    if (result != GLBK_OK) return result;
    if (d->lights_per_pass > GLBK__RSM_LIST / 2)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, __func__, "desc.lights_per_pass", d->lights_per_pass, 0,
                                  GLBK__RSM_LIST / 2);
    result = glbk__take_attributes(ctx, __func__, &d->attributes, &out->attributes);
    if (result != GLBK_OK) {
        memset(out, 0, sizeof *out);
        return result;
    }
    out->width = d->width;
    out->height = d->height;
    out->lights_per_pass = d->lights_per_pass ? d->lights_per_pass : 4096;
    out->compute = ctx->compute && (!d->interpolate || 4 * (size_t)d->width * d->height <= ctx->max_storage);
    result = glbk__rsm_image(ctx, GLBK_FORMAT_RGBA32UI, 1024, GLBK__RSM_LIST / 1024, 4, &out->lights);
    if (result == GLBK_OK) result = glbk__rsm_target(ctx, &out->lights, 0, 4, NULL, &out->lights_target);
    if (result == GLBK_OK) result = glbk__rsm_renderer_images(ctx, out, d->interpolate, d->denoise);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof out->values, NULL, &out->frame);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof out->drawn, NULL, &out->object);
    if (result == GLBK_OK)
        result = glbk_buffer_create(ctx, sizeof(glbk_rsm_imported), NULL, &out->imported);
    if (result != GLBK_OK) glbk_rsm_renderer_free(ctx, out);
    return result;
}

static void glbk__rsm_free_images(glbk_context *ctx, glbk_rsm_renderer *r)
{
    uint32_t i;
    for (i = 0; i < 3; i++) {
        glbk_target_free(ctx, &r->targets[i]);
        glbk_target_free(ctx, &r->grid_targets[i]);
        glbk_texture_free(ctx, &r->sums[i]);
        glbk_texture_free(ctx, &r->grids[i]);
    }
    for (i = 0; i < 2; i++) {
        glbk_target_free(ctx, &r->history_targets[i]);
        glbk_texture_free(ctx, &r->kept[i]);
        glbk_texture_free(ctx, &r->history[i]);
        glbk_buffer_free(ctx, &r->pending[i]);
    }
    glbk_buffer_free(ctx, &r->wanted);
    glbk_buffer_free(ctx, &r->marks);
    glbk_buffer_free(ctx, &r->counts);
}

GLBK_DEF glbk_result glbk_rsm_renderer_resize(glbk_context *ctx, glbk_rsm_renderer *r, uint32_t width,
                                              uint32_t height)
{
    const int interpolate = r && r->grids[0].name, denoise = r && r->history[0].name;
    const double bytes = 4.0 * width * height;
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_renderer_check(ctx, __func__, r);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "width", width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "height", height);
    if (result != GLBK_OK) return result;
    if (interpolate && r->compute && bytes > (double)ctx->max_storage)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, __func__, "4 width height", bytes, 4,
                                  (double)ctx->max_storage);
    glbk__rsm_free_images(ctx, r);
    r->width = width;
    r->height = height;
    result = glbk__rsm_renderer_images(ctx, r, interpolate, denoise);
    if (result != GLBK_OK) glbk_rsm_renderer_free(ctx, r);
    return result;
}

GLBK_DEF void glbk_rsm_renderer_free(glbk_context *ctx, glbk_rsm_renderer *r)
{
    uint32_t i;
    if (!r) return;
    for (i = 0; i < GLBK_RSM_PROGRAM_COUNT; i++) glbk_program_free(ctx, &r->programs[i]);
    glbk__rsm_free_images(ctx, r);
    glbk_target_free(ctx, &r->lights_target);
    glbk_texture_free(ctx, &r->lights);
    glbk_texture_free(ctx, &r->pattern);
    glbk_texture_free(ctx, &r->noise);
    glbk_texture_free(ctx, &r->materials);
    glbk_buffer_free(ctx, &r->frame);
    glbk_buffer_free(ctx, &r->object);
    glbk_buffer_free(ctx, &r->imported);
    memset(r, 0, sizeof *r);
}

/* Makes a table, with rows of `width` texels, from count items of n floats. */
static glbk_result glbk__rsm_table(glbk_context *ctx, const float *from, uint32_t count, uint32_t n,
                                   uint32_t width, glbk_texture *out)
{
    glbk_rsm__allocator memory = glbk_rsm__memory(ctx);
    uint32_t rows = (count + width - 1) / width, i;
    glbk_texture_desc d;
    glbk_result result;
    float *texels = (float *)glbk_rsm__alloc_array(&memory, (size_t)width * rows, 16);
    if (!texels) return GLBK_ERR_ALLOC;
    memset(texels, 0, (size_t)width * rows * 16);
    for (i = 0; i < count; i++) memcpy(texels + 4 * (size_t)i, from + n * (size_t)i, n * sizeof *from);
    memset(&d, 0, sizeof d);
    d.format = GLBK_FORMAT_RGBA32F;
    d.width = width;
    d.height = rows;
    d.data = texels;
    result = glbk_texture_create(ctx, &d, out);
    glbk_rsm__free(&memory, texels);
    return result;
}

/* Keeps the desc and the counts that glbk__rsm_tables_check compares. */
static void glbk__rsm_remember_tables(glbk_rsm_renderer *r, const rsm_gather_desc *d)
{
    r->tables = *d;
    r->tables.noise = NULL;
    r->tables.materials = NULL;
    r->point_count = glbk_rsm_point_count(d);
    r->noise_side = d->noise ? d->noise_side : 0;
    r->material_count = d->material_count;
}

GLBK_DEF glbk_result glbk_rsm_tables_upload(glbk_context *ctx, glbk_rsm_renderer *r,
                                            const rsm_gather_desc *desc, const float *points)
{
    rsm_gather_desc d;
    glbk_result result;
    uint32_t count;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_renderer_check(ctx, __func__, r);
    if (result == GLBK_OK) result = glbk__rsm_gather_check(ctx, __func__, desc, &d);
    if (result == GLBK_OK) result = glbk__rsm_values_check(ctx, &d);
    if (result != GLBK_OK) return result;
    count = glbk_rsm_point_count(&d);
    if (count && !points)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "points",
                            "is NULL, and the pattern needs some");
    if (!count && points)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "points",
                            "is not NULL, and the pattern needs none");
    glbk_texture_free(ctx, &r->pattern);
    glbk_texture_free(ctx, &r->noise);
    glbk_texture_free(ctx, &r->materials);
    memset(&r->tables, 0, sizeof r->tables);
    r->point_count = r->noise_side = r->material_count = 0;
    if (count) result = glbk__rsm_table(ctx, points, count, 3, GLBK__RSM_TABLE, &r->pattern);
    if (result == GLBK_OK && d.noise)
        result = glbk__rsm_table(ctx, d.noise, d.noise_side * d.noise_side, 1, d.noise_side, &r->noise);
    if (result == GLBK_OK && d.material_count)
        result = glbk__rsm_table(ctx, d.materials->specular, d.material_count, 4, GLBK__RSM_TABLE,
                                 &r->materials);
    if (result == GLBK_OK) glbk__rsm_remember_tables(r, &d);
    return result;
}

/* Compiles a program, unless that was done before. */
static glbk_result glbk__rsm_program(glbk_context *ctx, glbk_rsm_renderer *r, int which)
{
    const char *const *names = glbk__rsm_programs[which];
    const int blind = which < GLBK__RSM_DIRECT || which == GLBK__RSM_DO_SCAN ||
                      which == GLBK__RSM_DO_SCAN_ROWS;
    if (r->programs[which].name) return GLBK_OK;
    if (which == GLBK__RSM_FILL)
        return glbk__drawing_program(ctx, glbk_rsm_part(), names[0], &r->attributes, "", &r->programs[which]);
    if (blind) return glbk__program_create(ctx, glbk_rsm_part(), names[0], names[1], &r->programs[which]);
    return glbk__gbuffer_program(ctx, glbk_rsm_part(), names[0], names[1], &r->programs[which]);
}

/* Compiles a program and binds r->values as its block. A dispatch then only needs textures, images and
   lists. */
static glbk_result glbk__rsm_ready(glbk_context *ctx, glbk_rsm_renderer *r, int which)
{
    glbk_result result = glbk__rsm_program(ctx, r, which);
    return result == GLBK_OK ? glbk__put_block(ctx, GLBK_SLOT_glbk_rsm_frame, &r->frame, &r->values) : result;
}

/* Begins a pass over width x height pixels of a target. Textures are bound after this call. */
static glbk_result glbk__rsm_begin(glbk_context *ctx, glbk_rsm_renderer *r, int which,
                                   const glbk_target *target, uint32_t width, uint32_t height)
{
    glbk_pass pass;
    glbk_result result = glbk__rsm_ready(ctx, r, which);
    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    pass.viewport[2] = (int32_t)width;
    pass.viewport[3] = (int32_t)height;
    return glbk_begin(ctx, &pass, &r->programs[which]);
}

/* Binds the block and the textures of a map. */
static void glbk__rsm_bind_map(glbk_context *ctx, const glbk_rsm_map *map, const glbk_offset *offset)
{
    const glbk_offset at = glbk__offset(offset);
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_rsm_light, &map->buffer);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_rsm_texels, &map->texels);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_rsm_sums, &map->sums[map->sums_at]);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_rsm_rows, &map->rows[map->rows_at]);
}

GLBK_DEF void glbk_rsm_bind(glbk_context *ctx, const glbk_rsm_renderer *r, const glbk_rsm_map *map,
                            const glbk_offset *offset)
{
    const glbk_offset at = glbk__offset(offset);
    if (!ctx) return;
    if (map) glbk__rsm_bind_map(ctx, map, offset);
    if (!r) return;
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_rsm_frame, &r->frame);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_rsm_lights, &r->lights);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_rsm_pattern, &r->pattern);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_rsm_noise, &r->noise);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_rsm_materials, &r->materials);
}

/* Binds all that several programs of the library read. Pictures that one of them alone reads come after
   that. */
static void glbk__rsm_bind_all(glbk_context *ctx, const glbk_rsm_renderer *r, const glbk_gbuffer *gbuffer,
                               const glbk_rsm_map *map)
{
    glbk_rsm_bind(ctx, r, map, NULL);
    (void)glbk_gbuffer_bind(ctx, gbuffer, NULL);    /* The callers have checked it. */
}
