/* ---- buffers: through the copy target, which no vertex array or draw looks at ---- */

enum { GLBK__DYNAMIC_DRAW = 0x88E8, GLBK__ELEMENT_ARRAY_BUFFER_BINDING = 0x8895 };

static glbk_result glbk__buffer_make(glbk_context *ctx, const char *function, size_t bytes, const void *data,
                                     int indices, glbk_buffer *out)
{
    const uint32_t target = indices ? GLBK_GL_ELEMENT_ARRAY_BUFFER : GLBK_GL_COPY_WRITE_BUFFER;
    int32_t bound = 0;
    glbk_result result;

    result = glbk__enter_create(ctx, function, out, sizeof *out);
    if (result != GLBK_OK) return result;
    if (!bytes || bytes > PTRDIFF_MAX)
        return glbk__refuse_range(ctx, bytes ? GLBK_ERR_LIMIT : GLBK_ERR_ARGUMENT, function, "bytes",
                                  (double)bytes, 1, (double)PTRDIFF_MAX);
    ctx->gl.GetIntegerv(indices ? (uint32_t)GLBK__ELEMENT_ARRAY_BUFFER_BINDING : target, &bound);
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

/* WebGL lets a buffer hold indices only if it was bound as such first. Elsewhere indices go through the copy
   target, since the binding of indices belongs to a vertex array, and in core profiles none may be bound. */
GLBK_DEF glbk_result glbk_indices_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out)
{
    return glbk__buffer_make(ctx, __func__, bytes, data, ctx && ctx->webgl, out);
}

/* Checks that a run of bytes lies within a buffer, and that the memory for it, an argument of this name, is
   not NULL. */
static glbk_result glbk__check_run(const glbk_context *ctx, const char *function, const glbk_buffer *buffer,
                                   size_t offset, size_t bytes, const void *memory, const char *name)
{
    const glbk_result bad = GLBK_ERR_ARGUMENT;
    if (!memory) return glbk__refuse(ctx, bad, function, name, "is NULL");
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

    if (result == GLBK_OK) result = glbk__check_run(ctx, __func__, buffer, offset, bytes, data, "data");
    if (result != GLBK_OK) return result;
    ctx->gl.GetIntegerv(target, &bound);
    ctx->gl.BindBuffer(target, buffer->name);
    if (bytes == buffer->bytes) ctx->gl.BufferData(target, (ptrdiff_t)bytes, data, GLBK__DYNAMIC_DRAW);
    else ctx->gl.BufferSubData(target, (ptrdiff_t)offset, (ptrdiff_t)bytes, data);
    ctx->gl.BindBuffer(target, (uint32_t)bound);
    return glbk__leave_frame(ctx);
}

GLBK_DEF glbk_result glbk_buffer_read(glbk_context *ctx, const glbk_buffer *buffer, size_t offset,
                                      size_t bytes, void *out)
{
    int32_t bound = 0;
    glbk_result result = glbk__enter(ctx);

    if (result == GLBK_OK) result = glbk__check_run(ctx, __func__, buffer, offset, bytes, out, "out");
    if (result != GLBK_OK) return result;
    if (ctx->es)
        return glbk__refuse(ctx, GLBK_ERR_FEATURE, __func__, "ctx",
                            "is of OpenGL ES, which cannot read buffers");
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
