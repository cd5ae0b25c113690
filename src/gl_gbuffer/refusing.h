/* ---- gbuffer: why a call fails, for all techniques ---- */

GLBK__DEF glbk_result glbk__require(const glbk_context *ctx, const char *function, const char *field,
                                    const void *argument)
{
    if (ctx && argument) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, field, "is NULL");
}

GLBK__DEF glbk_result glbk__require_created(const glbk_context *ctx, const char *function, const char *field,
                                            const uint32_t *name)
{
    const glbk_result result = glbk__require(ctx, function, field, name);
    if (result != GLBK_OK || *name) return result;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, field, "was not created");
}

GLBK__DEF glbk_result glbk__require_side(const glbk_context *ctx, const char *function, const char *field,
                                         uint32_t side)
{
    const glbk_result result = side ? GLBK_ERR_LIMIT : GLBK_ERR_DESC;
    if (side && side <= ctx->max_side) return GLBK_OK;
    return glbk__refuse_range(ctx, result, function, field, side, 1, ctx->max_side);
}

GLBK__DEF glbk_result glbk__require_gbuffer(const glbk_context *ctx, const char *function,
                                            const glbk_gbuffer *gbuffer, uint32_t width, uint32_t height)
{
    glbk_result result =
        glbk__require_created(ctx, function, "gbuffer", gbuffer ? &gbuffer->colors.name : NULL);
    if (result != GLBK_OK) return result;
    result = GLBK_ERR_MISMATCH;
    if (gbuffer->width != width)
        return glbk__refuse_range(ctx, result, function, "gbuffer->width", gbuffer->width, width, width);
    if (gbuffer->height != height)
        return glbk__refuse_range(ctx, result, function, "gbuffer->height", gbuffer->height, height, height);
    return GLBK_OK;
}

GLBK__DEF void glbk__name_element(char out[GLBK__ELEMENT_ROOM], const char *array, size_t index,
                                  const char *member)
{
    glbk__sink sink;
    glbk__begin_line(&sink, out);
    glbk__append_text(&sink, array);
    if (index != GLBK__NO_INDEX) {
        glbk__append_text(&sink, "[");
        glbk__append_number(&sink, index);
        glbk__append_text(&sink, "]");
    }
    glbk__append_text(&sink, member);
}

GLBK__DEF glbk_result glbk__refuse_element(const glbk_context *ctx, glbk_result result, const char *function,
                                           const char *array, size_t index, const char *member,
                                           const char *text)
{
    char field[GLBK__ELEMENT_ROOM];
    glbk__name_element(field, array, index, member);
    return glbk__refuse(ctx, result, function, field, text);
}

GLBK__DEF glbk_result glbk__refuse_element_value(const glbk_context *ctx, glbk_result result,
                                                 const char *function, const char *array, size_t index,
                                                 const char *member, double value, const char *wanted)
{
    char field[GLBK__ELEMENT_ROOM];
    glbk__name_element(field, array, index, member);
    return glbk__refuse_value(ctx, result, function, field, value, wanted);
}
