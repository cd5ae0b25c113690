/* ---- what only the techniques need: logs of meshes, blocks of a pass, pictures ---- */

GLBK__DEF glbk_result glbk__refuse_index(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *mesh, size_t position, size_t index, size_t vertex_count)
{
    char field[GLBK__LINE_ROOM], text[GLBK__LINE_ROOM];
    glbk__sink sink;
    glbk__begin_line(&sink, field);
    glbk__append_text(&sink, mesh);
    glbk__append_text(&sink, ":");
    glbk__begin_line(&sink, text);
    glbk__append_text(&sink, "index ");
    glbk__append_number(&sink, position % 3);
    glbk__append_text(&sink, " of triangle ");
    glbk__append_number(&sink, position / 3);
    glbk__append_text(&sink, " is ");
    glbk__append_number(&sink, index);
    glbk__append_text(&sink, ", but the mesh has ");
    glbk__append_number(&sink, vertex_count);
    glbk__append_text(&sink, vertex_count == 1 ? " vertex" : " vertices");
    return glbk__refuse(ctx, result, function, field, text);
}

/* Two calls of GL, which go through the binding that a pass changes anyway. The storage is new each time, so
   that nothing waits for the draws before, copies what they read or, on GPUs that draw tile by tile, splits
   their pass. */
GLBK__DEF glbk_result glbk__put_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer,
                                      const void *values)
{
    const uint32_t target = GLBK_GL_UNIFORM_BUFFER;
    glbk_result result = glbk__enter_frame(ctx);
    if (ctx->lost) return GLBK_ERR_LOST;
    if (!buffer->name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, "a technique's pass", "its uniform block",
                            "was not created");
    /* The buffer is bound in spite of an error, since a callback may draw all the same. */
    ctx->gl.BindBufferBase(target, ctx->first_block + slot, buffer->name);
    if (result != GLBK_OK) return result;
    ctx->gl.BufferData(target, (ptrdiff_t)buffer->bytes, values, GLBK_GL_STREAM_DRAW);
    return glbk__leave_frame(ctx);
}

GLBK__DEF glbk_result glbk__canvas(glbk_context *ctx, glbk_format format, uint32_t width, uint32_t height,
                                   const glbk_texture *depth, glbk_texture *texture, glbk_target *target)
{
    glbk_texture_desc d;
    glbk_target_desc t;
    glbk_result result;
    if (!width || !height)
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, "a picture", width ? "height" : "width", 0,
                                  "1 or more");
    memset(&d, 0, sizeof d);
    memset(&t, 0, sizeof t);
    d.format = format;
    d.width = width;
    d.height = height;
    t.color[0] = texture;
    t.depth = depth;
    result = glbk_texture_create(ctx, &d, texture);
    return result == GLBK_OK ? glbk__target_create(ctx, &t, target) : result;
}

GLBK__DEF void glbk__sums_free(glbk_context *ctx, glbk_texture sums[2], glbk_target targets[2])
{
    int i;
    for (i = 0; i < 2; i++) {
        glbk_target_free(ctx, &targets[i]);
        glbk_texture_free(ctx, &sums[i]);
    }
}

GLBK__DEF glbk_result glbk__sums_create(glbk_context *ctx, int compute, uint32_t width, uint32_t height,
                                        glbk_texture sums[2], glbk_target targets[2])
{
    glbk_result result = GLBK_OK;
    int i;
    for (i = 0; i < (compute ? 1 : 2) && result == GLBK_OK; i++)
        result = glbk__canvas(ctx, GLBK_FORMAT_COLOR, width, height, NULL, &sums[i], &targets[i]);
    if (result != GLBK_OK) glbk__sums_free(ctx, sums, targets);
    return result;
}

/* ---- tables: texel i at (i & 1023, i >> 10 & 1023, i >> 20) ---- */

enum { GLBK__TABLE_BITS = 10, GLBK__TABLE_SIDE = 1 << GLBK__TABLE_BITS };

GLBK__DEF glbk_result glbk__table_create(glbk_context *ctx, glbk_format format, const void *texels,
                                         size_t count, glbk_texture *out)
{
    const size_t side = GLBK__TABLE_SIDE;
    glbk_texture_desc d;
    glbk_result result;
    size_t rows;

    if (out) memset(out, 0, sizeof *out);
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (ctx->lost) return GLBK_ERR_LOST;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    rows = count ? (count - 1) / side + 1 : 0;
    if (!count || (rows - 1) / side >= ctx->max_layers)
        return glbk__refuse_range(ctx, count ? GLBK_ERR_LIMIT : GLBK_ERR_ARGUMENT, __func__, "count",
                                  (double)count, 1, (double)ctx->max_layers * 1048576.0);
    memset(&d, 0, sizeof d);
    d.format = format;
    d.width = GLBK__TABLE_SIDE;
    d.height = (uint32_t)(rows < side ? rows : side);
    d.layers = (uint32_t)((rows - 1) / side + 1);
    result = glbk_texture_create(ctx, &d, out);
    if (result == GLBK_OK && texels)
        result = glbk__leave_created(ctx, glbk__table_update(ctx, out, 0, count, texels));
    if (result != GLBK_OK) glbk_texture_free(ctx, out);
    return result;
}

/* A run of texels is up to three boxes in each layer: the rest of a row, whole rows, the beginning of a
   row. */
GLBK__DEF glbk_result glbk__table_update(glbk_context *ctx, const glbk_texture *table, size_t first,
                                         size_t count, const void *texels)
{
    const size_t side = GLBK__TABLE_SIDE;
    const unsigned char *from = (const unsigned char *)texels;
    glbk__upload old;
    size_t room;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!table || !table->name || table->width != side || !table->layers)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "table", "was not made by glbk__table_create");
    if (!texels) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "texels", "is NULL");
    room = side * table->height * table->layers;
    if (first > room)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "first", (double)first, 0, (double)room);
    if (count > room - first)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "count", (double)count, 0,
                                  (double)(room - first));
    result = glbk__enter_frame(ctx);
    if (result != GLBK_OK || !count) return result;
    glbk__upload_begin(ctx, table, &old);
    while (count) {
        const size_t x = first % side, y = first / side % side;
        glbk_box box = { 0, 0, 0, 0, 0, 1, 1 };
        size_t texels_in_box;
        box.x = (uint32_t)x;
        box.y = (uint32_t)y;
        box.layer = (uint32_t)(first / side / side);
        if (x || count < side) {
            box.width = (uint32_t)(count < side - x ? count : side - x);
        } else {
            box.width = GLBK__TABLE_SIDE;
            box.height = (uint32_t)(count / side < side - y ? count / side : side - y);
        }
        glbk__upload_box(ctx, table, &box, from);
        texels_in_box = (size_t)box.width * box.height;
        from += texels_in_box * glbk__texel_bytes(table->format);
        first += texels_in_box;
        count -= texels_in_box;
    }
    glbk__upload_end(ctx, table, &old);
    return glbk__leave_frame(ctx);
}
