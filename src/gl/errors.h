/* ---- errors: GL's error flag ---- */

enum {
    GLBK__OUT_OF_MEMORY = 0x0505, GLBK__CONTEXT_LOST = 0x0507, GLBK__DRAW_FRAMEBUFFER_BINDING = 0x8CA6
};

/* Takes all errors that GL keeps, of which there may be one for each part of a distributed driver, and
   returns `otherwise` if there was one. The count is bounded since a driver without a context may return an
   error for ever. */
static glbk_result glbk__take_errors(glbk_context *ctx, glbk_result otherwise)
{
    uint32_t first = ctx->gl.GetError(), error = first;
    int i;
    for (i = 0; error && i < 64; i++) {
        if (error == GLBK__CONTEXT_LOST) {
            ctx->lost = 1;
            return GLBK_ERR_LOST;
        }
        if (error == GLBK__OUT_OF_MEMORY) first = error;
        error = ctx->gl.GetError();
    }
    if (!first) return GLBK_OK;
    glbk__log_constant(ctx, otherwise == GLBK_ERR_PENDING ? "before this call: GL error " : "GL error ",
                       first);
    return otherwise == GLBK_ERR_GL && first == GLBK__OUT_OF_MEMORY ? GLBK_ERR_GL_MEMORY : otherwise;
}

GLBK__DEF glbk_result glbk__enter(glbk_context *ctx)
{
    if (!ctx) return GLBK_ERR_ARGUMENT;
    return ctx->lost ? GLBK_ERR_LOST : glbk__take_errors(ctx, GLBK_ERR_PENDING);
}

GLBK__DEF glbk_result glbk__enter_create(glbk_context *ctx, const char *function, void *out, size_t bytes)
{
    if (out) memset(out, 0, bytes);
    if (!ctx) return GLBK_ERR_ARGUMENT;
    return out ? glbk__enter(ctx) : glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "out", "is NULL");
}

GLBK__DEF glbk_result glbk__leave(glbk_context *ctx) { return glbk__take_errors(ctx, GLBK_ERR_GL); }

/* Begins a call of a frame, which asks GL only if the user wants it: the answer makes browsers and drivers
   with threads of their own wait for all that was asked of them before. */
GLBK__DEF glbk_result glbk__enter_frame(glbk_context *ctx)
{
    if (!ctx || ctx->check) return glbk__enter(ctx);
    return ctx->lost ? GLBK_ERR_LOST : GLBK_OK;
}

GLBK__DEF glbk_result glbk__leave_frame(glbk_context *ctx) { return ctx->check ? glbk__leave(ctx) : GLBK_OK; }

GLBK__DEF glbk_result glbk__leave_created(glbk_context *ctx, glbk_result result)
{
    return result == GLBK_OK ? glbk__leave(ctx) : result;
}

GLBK__DEF glbk_result glbk__check_bound(const glbk_context *ctx, const char *function)
{
    int32_t bound = 0;
    if (!ctx->check || !ctx->inner) return GLBK_OK;
    ctx->gl.GetIntegerv(GLBK__DRAW_FRAMEBUFFER_BINDING, &bound);
    if ((uint32_t)bound != ctx->inner) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ORDER, function, "a technique's framebuffer",
                        "is still bound: after its passes bind your own");
}

GLBK_DEF glbk_result glbk_check(glbk_context *ctx)
{
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (ctx->lost) return GLBK_ERR_LOST;
    result = glbk__leave(ctx);
    return result == GLBK_OK ? glbk__check_bound(ctx, __func__) : result;
}
