/* ---- what only the techniques need: logs of meshes, blocks of a pass, pictures ---- */

GLBK__DEF glbk_result glbk__refuse_index(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *mesh, size_t position, size_t index, size_t vertex_count)
{
    glbk_prog__logger logger;
    logger.log = ctx->system.log;
    logger.user = ctx->system.user;
    logger.function = function;
    glbk_prog__log_index(&logger, mesh, position, index, vertex_count);
    return result;
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
