/* ---- targets: framebuffers of textures, and their pixels read back ---- */

enum {
    GLBK__READ_FRAMEBUFFER_BINDING = 0x8CAA, GLBK__FRAMEBUFFER_COMPLETE = 0x8CD5,
    GLBK__CLAMP_READ_COLOR = 0x891C, GLBK__NONE = 0, GLBK__FALSE = 0
};

/* Checks one attachment and takes its size, which all attachments have in common. */
static glbk_result glbk__check_attachment(const glbk_context *ctx, const glbk_target_desc *d, uint32_t i,
                                          glbk_target *out)
{
    static const char function[] = "glbk_target_create";
    static const char names[][14] = { "desc.color[0]", "desc.color[1]", "desc.color[2]", "desc.color[3]",
                                      "desc.depth" };
    const int is_color = i < GLBK_MAX_ATTACHMENTS;
    const glbk_texture *t = is_color ? d->color[i] : d->depth;
    const uint32_t layer = is_color ? d->layer[i] : d->depth_layer, layers = t->layers ? t->layers : 1;

    if (is_color && i != out->count)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, names[i], "stands behind a gap");
    if (!t->name) return glbk__refuse(ctx, GLBK_ERR_DESC, function, names[i], "was not created");
    if (d->level >= t->levels)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.level", d->level, 0,
                                  (double)t->levels - 1);
    if (layer >= layers)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, is_color ? "desc.layer" : "desc.depth_layer",
                                  layer, 0, (double)layers - 1);
    if (is_color == glbk__is_depth(t->format))
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, names[i],
                            is_color ? "is a depth texture" : "is no depth texture");
    if (glbk__is_float(t->format) && !ctx->float_targets)
        return glbk__refuse(ctx, GLBK_ERR_FLOAT_TARGET, function, names[i],
                            "is of floats, which this context cannot draw to");
    if (out->width && (out->width != glbk__level_side(t->width, d->level) ||
                       out->height != glbk__level_side(t->height, d->level)))
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, names[i],
                            "is of another size than those before it");
    out->width = glbk__level_side(t->width, d->level);
    out->height = glbk__level_side(t->height, d->level);
    if (is_color) out->format[out->count++] = t->format;
    else out->has_depth = 1;
    return GLBK_OK;
}

static glbk_result glbk__check_target(const glbk_context *ctx, const glbk_target_desc *d, glbk_target *out)
{
    glbk_result result = GLBK_OK;
    uint32_t i;
    for (i = 0; i <= GLBK_MAX_ATTACHMENTS && result == GLBK_OK; i++)
        if (i < GLBK_MAX_ATTACHMENTS ? d->color[i] : d->depth)
            result = glbk__check_attachment(ctx, d, i, out);
    if (result != GLBK_OK || out->width) return result;
    return glbk__refuse(ctx, GLBK_ERR_DESC, "glbk_target_create", "desc", "has no attachment");
}

GLBK__DEF void glbk__attach(const glbk_context *ctx, uint32_t attachment, const glbk_texture *t,
                            uint32_t level, uint32_t layer)
{
    if (!t) return;
    if (t->layers)
        ctx->gl.FramebufferTextureLayer(GLBK_GL_DRAW_FRAMEBUFFER, attachment, t->name, (int32_t)level,
                                        (int32_t)layer);
    else
        ctx->gl.FramebufferTexture2D(GLBK_GL_DRAW_FRAMEBUFFER, attachment, t->gl_target, t->name,
                                     (int32_t)level);
}

/* Makes a framebuffer without colours complete: OpenGL 3.3 wants that no colour is to be read from it
   either; 4.1 dropped that rule. */
static void glbk__read_nothing(const glbk_context *ctx, uint32_t name)
{
    int32_t bound = 0;
    ctx->gl.GetIntegerv(GLBK__READ_FRAMEBUFFER_BINDING, &bound);
    ctx->gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, name);
    ctx->gl.ReadBuffer(GLBK__NONE);
    ctx->gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, (uint32_t)bound);
}

GLBK_DEF glbk_result glbk_target_create(glbk_context *ctx, const glbk_target_desc *desc, glbk_target *out)
{
    uint32_t buffers[GLBK_MAX_ATTACHMENTS], i, status;
    int32_t bound = 0;
    glbk_result result;

    result = glbk__enter_create(ctx, __func__, out, sizeof *out);
    if (result != GLBK_OK) return result;
    if (!desc) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "desc", "is NULL");
    result = glbk__check_target(ctx, desc, out);
    if (result != GLBK_OK) {
        memset(out, 0, sizeof *out);
        return result;
    }
    ctx->gl.GetIntegerv(GLBK__DRAW_FRAMEBUFFER_BINDING, &bound);
    ctx->gl.GenFramebuffers(1, &out->name);
    ctx->gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, out->name);
    for (i = 0; i < out->count; i++) {
        buffers[i] = GLBK_GL_COLOR_ATTACHMENT0 + i;
        glbk__attach(ctx, buffers[i], desc->color[i], desc->level, desc->layer[i]);
    }
    glbk__attach(ctx, GLBK_GL_DEPTH_ATTACHMENT, desc->depth, desc->level, desc->depth_layer);
    if (!out->count) {
        buffers[0] = GLBK__NONE;
        glbk__read_nothing(ctx, out->name);
    }
    ctx->gl.DrawBuffers(out->count ? (int32_t)out->count : 1, buffers);
    status = ctx->gl.CheckFramebufferStatus(GLBK_GL_DRAW_FRAMEBUFFER);
    ctx->gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, (uint32_t)bound);
    result = glbk__leave(ctx);
    if (result == GLBK_OK && status != GLBK__FRAMEBUFFER_COMPLETE) {
        glbk__log_constant(ctx, "glbk_target_create: framebuffer status ", status);
        result = GLBK_ERR_TARGET;
    }
    if (result != GLBK_OK) glbk_target_free(ctx, out);
    return result;
}

GLBK__DEF glbk_result glbk__target_create(glbk_context *ctx, const glbk_target_desc *desc, glbk_target *out)
{
    const glbk_result result = glbk_target_create(ctx, desc, out);
    if (result == GLBK_OK) out->inner = 1;
    return result;
}

/* Makes floats of bytes 0..255: `rgba` has room for count pixels of four floats, and the bytes stand at its
   end. */
static void glbk__bytes_to_floats(void *rgba, size_t count)
{
    const unsigned char *from = (const unsigned char *)rgba + 12 * count;
    float *to = (float *)rgba, pixel[4];
    size_t i, k;
    for (i = 0; i < count; i++) {       /* a pixel overwrites none that is still to come */
        for (k = 0; k < 4; k++) pixel[k] = (float)from[4 * i + k] / 255.0f;
        memcpy(to + 4 * i, pixel, sizeof pixel);
    }
}

GLBK_DEF glbk_result glbk_target_read(glbk_context *ctx, const glbk_target *target, uint32_t attachment,
                                      uint32_t x, uint32_t y, uint32_t width, uint32_t height, void *rgba)
{
    glbk__store store;
    int32_t bound = 0, clamp = 0;
    int integer, bytes;
    size_t count = (size_t)width * height;
    glbk_result result = glbk__enter(ctx);

    if (result != GLBK_OK) return result;
    if (!target || !target->name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "target", "was not created");
    if (!rgba) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "rgba", "is NULL");
    if (attachment >= target->count)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "attachment", attachment, 0,
                                  (double)target->count - 1);
    result = glbk__check_span(ctx, __func__, "x + width", (uint64_t)x + width, target->width);
    if (result == GLBK_OK)
        result = glbk__check_span(ctx, __func__, "y + height", (uint64_t)y + height, target->height);
    if (result != GLBK_OK) return result;
    integer = glbk__is_integer(target->format[attachment]);
    /* Of formats of bytes, ES gives no floats. */
    bytes = ctx->es && !integer && !glbk__is_float(target->format[attachment]);
    ctx->gl.GetIntegerv(GLBK__READ_FRAMEBUFFER_BINDING, &bound);
    ctx->gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, target->name);
    ctx->gl.ReadBuffer(GLBK_GL_COLOR_ATTACHMENT0 + attachment);
    glbk__store_begin(ctx, GLBK__PACK, &store);
    if (!ctx->es) {
        ctx->gl.GetIntegerv(GLBK__CLAMP_READ_COLOR, &clamp);
        ctx->gl.ClampColor(GLBK__CLAMP_READ_COLOR, GLBK__FALSE);
    }
    ctx->gl.ReadPixels((int32_t)x, (int32_t)y, (int32_t)width, (int32_t)height,
                       integer ? GLBK__RGBA_INTEGER : GLBK__RGBA,
                       integer ? GLBK_GL_UNSIGNED_INT
                       : bytes ? GLBK_GL_UNSIGNED_BYTE
                               : GLBK_GL_FLOAT,
                       (unsigned char *)rgba + (bytes ? 12 * count : 0));
    if (!ctx->es) ctx->gl.ClampColor(GLBK__CLAMP_READ_COLOR, (uint32_t)clamp);
    glbk__store_end(ctx, GLBK__PACK, &store);
    ctx->gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, (uint32_t)bound);
    result = glbk__leave(ctx);
    if (result == GLBK_OK && bytes) glbk__bytes_to_floats(rgba, count);
    return result;
}

GLBK_DEF void glbk_target_free(glbk_context *ctx, glbk_target *target)
{
    if (!target) return;
    if (ctx && !ctx->lost && target->name) ctx->gl.DeleteFramebuffers(1, &target->name);
    if (ctx && ctx->inner == target->name) ctx->inner = 0;
    memset(target, 0, sizeof *target);
}
