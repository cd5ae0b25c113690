/* ---- sfield: building: views from sample points ---- */

/* Returns the samples a side of a face for an eye, which lie as close as those of sfield_build. */
static uint32_t glbk__sfield_width(const glbk_sfield_builder *b, const float *eye)
{
    float d = sqrtf(eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2]);
    uint32_t most = b->source ? 256 : 512, width;
    if (most > 64 * b->side) most = 64 * b->side;
    for (width = 64; width < most && ((float)width < 24 * d || width < 2 * b->side);) width *= 2;
    return width;
}

/* Returns 1 if a sphere, whose centre is given in radii from the eye, may reach into the pyramid of a face.
   In doubt the result is 1, since a face that is drawn in vain costs time only. */
static int glbk__sfield_faces(const float *center, float radius, uint32_t face)
{
    uint32_t axis = face / 2, k;
    float along = face % 2 ? -center[axis] : center[axis], reach = 1.001f * radius * 1.41421356f;
    if (along < -1.001f * radius) return 0;
    for (k = 0; k < 3; k++)
        if (k != axis && fabsf(center[k]) - along > reach) return 0;
    return 1;
}

/* Draws the tiles of one atlas, column by column, and counts their samples into the cubes. */
static glbk_result glbk__sfield_draw_tiles(glbk_context *ctx, glbk_sfield_builder *b, uint32_t tiles)
{
    static const float none[4] = { 0, 0, 0, 0 };
    const uint32_t width = b->views->width, rows = b->views->rows;
    glbk_pass pass;
    glbk_result result;
    uint32_t first;

    memset(&pass, 0, sizeof pass);
    pass.target = &b->seen_target;
    pass.depth = b->source ? GLBK_DEPTH_LESS : GLBK_DEPTH_OFF;
    pass.viewport[2] = (int32_t)width;
    pass.viewport[3] = (int32_t)(rows * width);
    for (first = 0; first < tiles; first += rows) {
        const int32_t count = (int32_t)(tiles - first < rows ? tiles - first : rows);
        b->views->first_tile = first;
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_sfield_views, &b->block, b->views);
        pass.viewport[0] = (int32_t)(first / rows * width);
        if (result == GLBK_OK) result = glbk_begin(ctx, &pass, &b->see);
        if (result != GLBK_OK) return result;
        if (!first) {
            glbk_clear(ctx, &b->seen_target, 0, none);
            if (b->source) glbk_clear_depth(ctx, 1);
        }
        if (b->draw_fn) b->draw_fn(b->user, ctx, count);
        else {
            ctx->gl.BindVertexArray(b->vertex_array);
            ctx->gl.DrawElementsInstanced(GLBK_GL_TRIANGLES, (int32_t)b->index_count, GLBK_GL_UNSIGNED_INT,
                                          NULL, count);
        }
    }
    memset(&pass, 0, sizeof pass);
    pass.target = &b->cube_target;
    result = b->compute ? GLBK_OK : glbk_begin(ctx, &pass, &b->sum);
    if (result != GLBK_OK) return result;
    glbk_bind_block(ctx, GLBK_SLOT_glbk_sfield_views, &b->block);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_seen, &b->seen);
    if (b->compute) {
        glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_cube_image, &b->cube);
        return glbk_dispatch(ctx, &b->sum, b->side, tiles, 1);
    }
    ctx->gl.DrawArraysInstanced(GLBK_GL_TRIANGLE_STRIP, 0, 4, (int32_t)tiles);
    return GLBK_OK;
}

/* Draws the cubes of a batch of eyes that take tiles of one width. Faces that see nothing are not drawn. */
static glbk_result glbk__sfield_draw_cubes(glbk_context *ctx, glbk_sfield_builder *b, uint32_t count,
                                           const float *eyes)
{
    static const float none[4] = { 0, 0, 0, 0 };
    glbk_sfield_views *v = b->views;
    const uint32_t width = v->width, rows = b->height / width;
    uint32_t most = rows * rows < GLBK__SFIELD_TILES ? rows * rows : (uint32_t)GLBK__SFIELD_TILES;
    uint32_t tiles = 0, i, face, k;
    glbk_pass pass;
    glbk_result result;

    memset(&pass, 0, sizeof pass);
    pass.target = &b->cube_target;
    result = glbk_begin(ctx, &pass, &b->see);
    if (result != GLBK_OK) return result;
    glbk_clear(ctx, &b->cube_target, 0, none);
    v->rows = rows;
    for (i = 0; i < count && result == GLBK_OK; i++) {
        const float *eye = eyes + 3 * (size_t)i;
        float center[3] = { 0, 0, 0 }, radius = 1, far_depth = 0;
        for (k = 0; k < 3; k++) {
            if (!b->draw_fn) center[k] = (b->center[k] - v->sphere[k]) / v->sphere[3];
            center[k] -= eye[k];
            far_depth += center[k] * center[k];
        }
        if (!b->draw_fn) radius = b->radius / v->sphere[3];
        far_depth = 1.001f * (sqrtf(far_depth) + radius);
        for (face = 0; face < 6 && result == GLBK_OK; face++) {
            float *at = v->eyes + 4 * (size_t)tiles;
            uint32_t *place = v->places + 4 * (size_t)tiles;
            if (!glbk__sfield_faces(center, radius, face)) continue;
            memcpy(at, eye, 12);
            at[3] = 1 / far_depth;
            place[0] = face;
            place[1] = i;
            place[2] = tiles / rows;
            place[3] = tiles % rows;
            if (++tiles < most) continue;
            result = glbk__sfield_draw_tiles(ctx, b, tiles);
            tiles = 0;
        }
    }
    return result == GLBK_OK && tiles ? glbk__sfield_draw_tiles(ctx, b, tiles) : result;
}

/* Projects the cubes of a batch and reads the coefficients back. */
static glbk_result glbk__sfield_read_coefs(glbk_context *ctx, glbk_sfield_builder *b, uint32_t count,
                                           float *values)
{
    const uint32_t n = b->bands * b->bands, channels = b->source ? 3 : 1, width = b->groups * channels;
    uint32_t i, c;
    glbk_pass pass;
    glbk_result result = GLBK_OK;

    memset(&pass, 0, sizeof pass);
    pass.target = &b->coef_target;
    pass.viewport[2] = (int32_t)width;
    pass.viewport[3] = (int32_t)count;
    if (!b->compute) result = glbk_begin(ctx, &pass, &b->project);
    if (result != GLBK_OK) return result;
    glbk_bind_block(ctx, GLBK_SLOT_glbk_sfield_views, &b->block);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_cube, &b->cube);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_basis, &b->basis);
    if (b->compute) {
        glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_coefs_image, &b->coefs);
        result = glbk_dispatch(ctx, &b->project, count, channels, 1);
    } else glbk_draw_screen(ctx);
    if (result == GLBK_OK) result = glbk_target_read(ctx, &b->coef_target, 0, 0, 0, width, count, b->words);
    for (i = 0; i < count && result == GLBK_OK; i++)
        for (c = 0; c < channels; c++, values += n)
            memcpy(values, b->words + 4 * ((size_t)i * width + c * b->groups), n * sizeof *values);
    return result;
}

/* Copies a row of a face's texels to the values of an eye, channel by channel. */
static void glbk__sfield_copy_row(const glbk_sfield_builder *b, const uint32_t *row, uint32_t face,
                                  uint32_t y, float *values)
{
    const uint32_t channels = b->source ? 3 : 1, words = b->source ? 4 : 1;
    const size_t cells = (size_t)6 * b->side * b->side;
    uint32_t x, c;
    for (x = 0; x < b->side; x++)
        for (c = 0; c < channels; c++)
            memcpy(values + c * cells + glbk__sfield_morton(b->side, face, x, y), row + x * words + c,
                   sizeof *values);
}

/* Reads the texels of the cubes of a batch back. */
static glbk_result glbk__sfield_read_texels(glbk_context *ctx, glbk_sfield_builder *b, uint32_t count,
                                            float *values)
{
    const uint32_t side = b->side, words = b->source ? 4 : 1;
    const size_t numbers = glbk__sfield_values(b) * (b->source ? 3u : 1u);
    uint32_t i, face, y;
    const uint32_t *from = b->words;
    glbk_result result =
        glbk_target_read(ctx, &b->cube_target, 0, 0, 0, b->cube.width, count * side, b->words);

    for (i = 0; i < count && result == GLBK_OK; i++, values += numbers)
        for (y = 0; y < side; y++)
            for (face = 0; face < 6; face++, from += side * words)
                glbk__sfield_copy_row(b, from, face, y, values);
    return result;
}

/* Checks the arguments of glbk_sfield_builder_see. */
static glbk_result glbk__sfield_check_views(const glbk_context *ctx, const char *function,
                                            const glbk_sfield_builder *b, const sfield_views *v)
{
    glbk_sfield__message name;
    size_t i;
    if (!b || !b->words)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "builder", b ? "was not created" : "is NULL");
    if (!v || !v->eyes || !v->values)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function,
                            !v         ? "views"
                            : !v->eyes ? "views.eyes"
                                       : "views.values",
                            "is NULL");
    if (!v->count) return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, function, "views.count", 0, "> 0");
    if (!(v->radius > 0) || !glbk_sfield__finite(v->radius))
        return glbk__refuse_value(ctx, GLBK_ERR_INPUT, function, "views.radius", (double)v->radius,
                                  "> 0 and finite");
    for (i = 0; i < 3; i++)
        if (!glbk_sfield__finite(v->center[i]))
            return glbk__refuse_value(ctx, GLBK_ERR_INPUT, function,
                                      glbk__sfield_name(&name, "views.center", i, ""),
                                      (double)v->center[i], "finite");
    for (i = 0; i < 3 * v->count; i++)
        if (!(fabsf(v->eyes[i]) < 1e6f))
            return glbk__refuse_value(ctx, GLBK_ERR_INPUT, function,
                                      glbk__sfield_name(&name, "views.eyes", i, ""), (double)v->eyes[i],
                                      "-1e6..1e6");
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_sfield_builder_see(glbk_context *ctx, glbk_sfield_builder *b, const sfield_views *v)
{
    float *values;
    size_t from;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_views(ctx, __func__, b, v);
    if (result != GLBK_OK) return result;
    values = v->values;
    memset(b->views, 0, sizeof *b->views);
    memcpy(b->views->sphere, v->center, sizeof v->center);
    b->views->sphere[3] = v->radius;
    b->views->side = b->side;
    b->views->batch = b->batch;
    b->views->groups = b->groups;
    for (from = 0; from < v->count && result == GLBK_OK;) {
        const float *eyes = v->eyes + 3 * from;
        uint32_t width = glbk__sfield_width(b, eyes), n = 1;
        while (n < b->batch && from + n < v->count && glbk__sfield_width(b, eyes + 3 * (size_t)n) == width)
            n++;
        b->views->width = width;
        result = glbk__sfield_draw_cubes(ctx, b, n, eyes);
        if (result == GLBK_OK)
            result = b->bands ? glbk__sfield_read_coefs(ctx, b, n, values)
                              : glbk__sfield_read_texels(ctx, b, n, values);
        values += n * glbk__sfield_values(b) * (b->source ? 3u : 1u);
        from += n;
    }
    return result;
}
