/* ---- sfield: self-visibility: drawn or uploaded, pixel by pixel ---- */

GLBK__DEF glbk_result glbk__sfield_blank(glbk_context *ctx, const glbk_texture *self)
{
    const glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
    void *zeros = glbk_sfield__alloc_array(&memory, self->width, 16);
    glbk_result result = GLBK_OK;
    uint32_t y;

    if (!zeros) return GLBK_ERR_ALLOC;
    memset(zeros, 0, (size_t)self->width * 16);
    for (y = 0; y < self->height && result == GLBK_OK; y++) {
        const glbk_box box = { 0, 0, y, 0, self->width, 1, 1 };
        result = glbk_texture_update(ctx, self, &box, zeros);
    }
    glbk_sfield__free(&memory, zeros);
    return result;
}

/* Makes the texture of self-visibility, in which nothing is recorded yet. */
static glbk_result glbk__sfield_self_create(glbk_context *ctx, glbk_sfield_renderer *r)
{
    glbk_texture_desc texture;
    glbk_result result;

    memset(&texture, 0, sizeof texture);
    texture.format = GLBK_FORMAT_RGBA32UI;
    texture.width = r->width;
    texture.height = r->height;
    texture.layers = (r->bands * r->bands + 7) / 8;
    if (texture.layers < 2) texture.layers = 2;         /* since drawing writes two */
    result = glbk_texture_create(ctx, &texture, &r->self);
    return result == GLBK_OK ? glbk__sfield_blank(ctx, &r->self) : result;
}

/* Returns a coefficient in signed 16 bits, with 32767 for 1.5, since functions that are at most a cosine have
   norms up to 1.45. */
static uint32_t glbk__sfield_short(float x)
{
    x = x * (1 / 1.5f);
    x = x > -1 ? (x < 1 ? x : 1) : -1;
    return (uint32_t)(int32_t)(x * 32767 + (x < 0 ? -0.5f : 0.5f)) & 0xffffu;
}

/* Checks that a renderer has self-visibility. */
static glbk_result glbk__sfield_check_self(const glbk_context *ctx, const char *function,
                                           const glbk_sfield_renderer *r)
{
    if (!r || !r->shade.name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "renderer", r ? "was not created" : "is NULL");
    if (!r->self.name)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "renderer", "was created without desc.self");
    return GLBK_OK;
}

GLBK__DEF glbk_result glbk__sfield_check_gbuffer(const glbk_context *ctx, const char *function,
                                                 uint32_t width, uint32_t height, const glbk_gbuffer *g)
{
    if (!g || !g->words[0].name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "gbuffer", g ? "was not created" : "is NULL");
    if (g->width != width)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "gbuffer->width", g->width,
                                  "that of the renderer");
    if (g->height != height)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "gbuffer->height", g->height,
                                  "that of the renderer");
    return GLBK_OK;
}

GLBK__DEF glbk_result glbk__sfield_check_rows(const glbk_context *ctx, const char *function, uint32_t height,
                                              uint32_t row, uint32_t row_count)
{
    if (row >= height) return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, function, "row", row, 0, height - 1);
    if (row_count && row_count <= height - row) return GLBK_OK;
    return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, function, "row_count", row_count, 1, height - row);
}

GLBK_DEF glbk_result glbk_sfield_self_upload(glbk_context *ctx, glbk_sfield_renderer *r, uint32_t row,
                                             uint32_t row_count, const float *const *self)
{
    glbk_box box = { 0, 0, 0, 0, 0, 0, 1 };
    glbk_sfield__allocator memory;
    uint32_t *words, layer, k, n;
    size_t count, i;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_self(ctx, __func__, r);
    if (result != GLBK_OK) return result;
    if (!self) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "self", "is NULL");
    result = glbk__sfield_check_rows(ctx, __func__, r->height, row, row_count);
    if (result != GLBK_OK) return result;
    memory = glbk_sfield__memory(ctx);
    count = (size_t)r->width * row_count;
    n = r->bands * r->bands;
    words = (uint32_t *)glbk_sfield__alloc_array(&memory, count, 16);
    if (!words) return GLBK_ERR_ALLOC;
    box.y = row;
    box.width = r->width;
    box.height = row_count;
    for (layer = 0; 8 * layer < n && result == GLBK_OK; layer++) {
        memset(words, 0, 16 * count);
        for (i = 0; i < count; i++) {
            for (k = 0; k < 8 && 8 * layer + k < n && self[i]; k++)
                words[4 * i + k / 2] |= glbk__sfield_short(self[i][8 * layer + k]) << k % 2 * 16;
            if (!layer && self[i] && !(words[4 * i] & 0xffffu))
                words[4 * i] |= 1;      /* since 0 says that none was recorded */
        }
        box.layer = layer;
        result = glbk_texture_update(ctx, &r->self, &box, words);
    }
    glbk_sfield__free(&memory, words);
    return result;
}

/* Compiles the program for meshes as the G-buffer draws them, unless there is one. */
static glbk_result glbk__sfield_record(glbk_context *ctx, glbk_sfield_renderer *r, const glbk_attributes *at)
{
    static const char *const names[4] = { "GLBK_PLACE SFIELD_SELF0=", " SFIELD_SELF1=", " SFIELD_SELF2=",
                                          " SFIELD_SELF3=" };
    char defines[96];
    glbk_attributes place;
    glbk__sink sink;
    uint32_t i;

    if (r->record.name && r->record_vertex == at->vertex && r->record_position == at->position)
        return GLBK_OK;
    glbk_program_free(ctx, &r->record);
    r->record_vertex = at->vertex;
    r->record_position = at->position;
    place = *at;
    place.fragment = NULL;      /* the depth test leaves out holes */
    sink.out = defines;
    sink.bytes = sizeof defines;
    sink.used = 0;
    for (i = 0; i < 4; i++) {
        glbk__append_text(&sink, names[i]);
        glbk__sfield_number(&sink, r->self_attribute + i);
    }
    defines[sink.used] = 0;
    return glbk__drawing_program(ctx, glbk_sfield_part(), "sfield_self.frag", &place, defines, &r->record);
}

GLBK_DEF glbk_result glbk_sfield_self_begin(glbk_context *ctx, glbk_sfield_renderer *r, const glbk_gbuffer *g)
{
    static const float zero[4] = { 0, 0, 0, 0 };
    glbk_target_desc target;
    glbk_result result;
    glbk_pass pass;
    uint32_t i;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_self(ctx, __func__, r);
    if (result == GLBK_OK) result = glbk__sfield_check_gbuffer(ctx, __func__, r->width, r->height, g);
    if (result != GLBK_OK) return result;
    if (!g->has_depth || !g->has_clip)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "gbuffer",
                            "was not drawn: its depth or matrix is not known");
    if (r->bands > 4)
        return glbk__refuse_value(ctx, GLBK_ERR_LIMIT, __func__, "the number of bands", r->bands,
                                  "1..4 to be drawn");
    if (!g->attributes.vertex && g->attributes.position >= (int32_t)r->self_attribute &&
        g->attributes.position < (int32_t)r->self_attribute + 4)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, __func__, "desc.self_attribute", r->self_attribute,
                                  "such that the position is in none of four attributes from it on");
    result = glbk__sfield_record(ctx, r, &g->attributes);
    memset(&target, 0, sizeof target);
    target.color[0] = target.color[1] = &r->self;
    target.layer[1] = 1;
    target.depth = &g->depth;
    if (result == GLBK_OK && !r->self_target.name)
        result = glbk__target_create(ctx, &target, &r->self_target);
    memset(&pass, 0, sizeof pass);
    pass.target = &r->self_target;
    pass.depth = GLBK_DEPTH_EQUAL;
    if (result == GLBK_OK) result = glbk_begin(ctx, &pass, &r->record);
    if (result == GLBK_OK)
        glbk__attach(ctx, GLBK_GL_DEPTH_ATTACHMENT, &g->depth, 0, 0);   /* since the buffer may be another */
    for (i = 0; i < 2 && result == GLBK_OK; i++) glbk_clear(ctx, &r->self_target, i, zero);
    memcpy(r->world_to_clip, g->world_to_clip, sizeof r->world_to_clip);
    return result;
}

GLBK_DEF glbk_result glbk_sfield_self_object(glbk_context *ctx, glbk_sfield_renderer *r,
                                             const float transform[16])
{
    glbk_sfield_object object;
    glbk_result result;
    int i, given = 0;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_self(ctx, __func__, r);
    if (result != GLBK_OK) return result;
    if (!transform) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "transform", "is NULL");
    if (!r->self_target.name)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "renderer",
                            "was not begun: glbk_sfield_self_begin");
    memset(&object, 0, sizeof object);
    memcpy(object.transform, transform, sizeof object.transform);
    for (i = 0; i < 16; i++) given = given || transform[i] != 0;
    for (i = 0; i < 16 && !given; i += 5) object.transform[i] = 1;
    memcpy(object.clip, r->world_to_clip, sizeof object.clip);
    return glbk__put_block(ctx, GLBK_SLOT_glbk_sfield_object, &r->object, &object);
}
