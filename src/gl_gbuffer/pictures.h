/* ---- gbuffer: pictures of the techniques ---- */

/* Finds where a resolve draws its picture: the corner of the viewport. See glbk_picture. */
static glbk_result glbk__gbuffer_corner(const glbk_context *ctx, const char *function,
                                        const glbk_pass *pass, uint32_t width, uint32_t height,
                                        glbk_shown *shown)
{
    const int32_t *v = pass->viewport;
    const int whole = pass->target && !v[2] && !v[3];
    const uint32_t wide = whole ? pass->target->width : (uint32_t)v[2];
    const uint32_t high = whole ? pass->target->height : (uint32_t)v[3];

    shown->left = whole ? 0u : (uint32_t)v[0];
    shown->bottom = whole ? 0u : (uint32_t)v[1];
    if (wide <= width && high <= height) return GLBK_OK;
    if (wide > width)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "the width that pass draws to", wide, 0,
                                  width);
    return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "the height that pass draws to", high, 0, height);
}

GLBK__DEF glbk_result glbk__begin_picture(glbk_context *ctx, const char *function, const glbk_pass *pass,
                                          const glbk_picture *picture, uint32_t width, uint32_t height,
                                          glbk_program *program)
{
    glbk_shown shown;
    glbk_buffer buffer;
    glbk_result result;
    memset(&shown, 0, sizeof shown);
    result = pass->target ? GLBK_OK : glbk__check_bound(ctx, function);
    if (result == GLBK_OK) result = glbk__gbuffer_corner(ctx, function, pass, width, height, &shown);
    if (result == GLBK_OK) result = glbk_begin(ctx, pass, program);
    if (result != GLBK_OK) return result;
    shown.keep_empty = picture && picture->keep_empty;
    shown.has_depth = picture && picture->world_to_clip;
    if (shown.has_depth) memcpy(shown.to_clip, picture->world_to_clip, sizeof shown.to_clip);
    buffer.name = ctx->shown;
    buffer.bytes = sizeof shown;
    return glbk__put_block(ctx, GLBK_SLOT_glbk_shown, &buffer, &shown);
}
