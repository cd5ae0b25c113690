/* ---- buffers: through the copy target, which no vertex array or draw looks at ---- */

enum { GLBK__DYNAMIC_DRAW = 0x88E8 };

static glbk_result glbk__buffer_make(glbk_context *ctx, const char *function, size_t bytes, const void *data,
                                     int indices, glbk_buffer *out)
{
    const uint32_t target = indices ? GLBK_GL_ELEMENT_ARRAY_BUFFER : GLBK_GL_COPY_WRITE_BUFFER;
    int32_t bound = 0;
    glbk_result result;

    if (!out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    result = glbk__enter(ctx);
    if (result != GLBK_OK) return result;
    if (!bytes || bytes > PTRDIFF_MAX)
        return glbk__refuse_range(ctx, bytes ? GLBK_ERR_LIMIT : GLBK_ERR_ARGUMENT, function, "bytes",
                                  (double)bytes, 1, (double)PTRDIFF_MAX);
    ctx->gl.GetIntegerv(indices ? 0x8895 /* ELEMENT_ARRAY_BUFFER_BINDING */ : target, &bound);
    ctx->gl.GenBuffers(1, &out->name);
    ctx->gl.BindBuffer(target, out->name);
    ctx->gl.BufferData(target, (ptrdiff_t)bytes, data, GLBK_GL_STATIC_DRAW);
    ctx->gl.BindBuffer(target, (uint32_t)bound);
    out->bytes = bytes;
    result = glbk__leave(ctx);
    if (result != GLBK_OK) glbk_buffer_free(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_buffer_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out)
{
    return glbk__buffer_make(ctx, __func__, bytes, data, 0, out);
}

/* WebGL remembers what a buffer was bound to first. Elsewhere through the copy target as well: this one
   belongs to the vertex array, and core profiles need not have one bound. */
GLBK_DEF glbk_result glbk_indices_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out)
{
    return glbk__buffer_make(ctx, __func__, bytes, data, ctx && ctx->webgl, out);
}

/* Whether a run of bytes lies within a buffer, whose memory is at `memory`. */
static glbk_result glbk__check_run(const glbk_context *ctx, const char *function, const glbk_buffer *buffer,
                                   size_t offset, size_t bytes, const void *memory)
{
    const glbk_result bad = GLBK_ERR_ARGUMENT;
    if (!memory) return glbk__refuse(ctx, bad, function, "the data", "are NULL");
    if (!buffer || !buffer->name) return glbk__refuse(ctx, bad, function, "buffer", "was not created");
    if (offset > buffer->bytes)
        return glbk__refuse_range(ctx, bad, function, "offset", (double)offset, 0, (double)buffer->bytes);
    if (bytes <= buffer->bytes - offset) return GLBK_OK;
    return glbk__refuse_range(ctx, bad, function, "bytes", (double)bytes, 0,
                              (double)(buffer->bytes - offset));
}

GLBK_DEF glbk_result glbk_buffer_update(glbk_context *ctx, const glbk_buffer *buffer, size_t offset,
                                        size_t bytes, const void *data)
{
    const uint32_t target = GLBK_GL_COPY_WRITE_BUFFER;
    int32_t bound = 0;
    glbk_result result = glbk__enter_frame(ctx);

    if (result == GLBK_OK) result = glbk__check_run(ctx, __func__, buffer, offset, bytes, data);
    if (result != GLBK_OK) return result;
    ctx->gl.GetIntegerv(target, &bound);
    ctx->gl.BindBuffer(target, buffer->name);
    if (bytes == buffer->bytes) ctx->gl.BufferData(target, (ptrdiff_t)bytes, data, GLBK__DYNAMIC_DRAW);
    else ctx->gl.BufferSubData(target, (ptrdiff_t)offset, (ptrdiff_t)bytes, data);
    ctx->gl.BindBuffer(target, (uint32_t)bound);
    return glbk__leave_frame(ctx);
}

/* All values of a block for the draws that follow, bound to its slot: two calls, which go through the binding
   that a pass changes anyway. The storage is new, so that nothing waits for the draws before, copies what
   they read or, on GPUs that draw tile by tile, splits their pass. */
GLBK__DEF glbk_result glbk__put_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer,
                                      const void *values)
{
    const uint32_t target = GLBK_GL_UNIFORM_BUFFER;
    glbk_result result = glbk__enter_frame(ctx);
    if (ctx->lost || !buffer->name) return ctx->lost ? GLBK_ERR_LOST : GLBK_ERR_ARGUMENT;
    /* Even so: a callback may draw in spite of an error. */
    ctx->gl.BindBufferBase(target, ctx->first_block + slot, buffer->name);
    if (result != GLBK_OK) return result;
    ctx->gl.BufferData(target, (ptrdiff_t)buffer->bytes, values, GLBK_GL_STREAM_DRAW);
    return glbk__leave_frame(ctx);
}

GLBK_DEF glbk_result glbk_buffer_read(glbk_context *ctx, const glbk_buffer *buffer, size_t offset,
                                      size_t bytes, void *out)
{
    int32_t bound = 0;
    glbk_result result = glbk__enter(ctx);

    if (result == GLBK_OK) result = glbk__check_run(ctx, __func__, buffer, offset, bytes, out);
    if (result != GLBK_OK) return result;
    if (ctx->es) return GLBK_ERR_FEATURE;
    ctx->gl.GetIntegerv(GLBK_GL_COPY_WRITE_BUFFER, &bound);
    ctx->gl.BindBuffer(GLBK_GL_COPY_WRITE_BUFFER, buffer->name);
    ctx->gl.GetBufferSubData(GLBK_GL_COPY_WRITE_BUFFER, (ptrdiff_t)offset, (ptrdiff_t)bytes, out);
    ctx->gl.BindBuffer(GLBK_GL_COPY_WRITE_BUFFER, (uint32_t)bound);
    return glbk__leave(ctx);
}

GLBK_DEF void glbk_buffer_free(glbk_context *ctx, glbk_buffer *buffer)
{
    if (!buffer) return;
    if (ctx && !ctx->lost && buffer->name) ctx->gl.DeleteBuffers(1, &buffer->name);
    memset(buffer, 0, sizeof *buffer);
}
