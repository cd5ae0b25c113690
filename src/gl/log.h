/* ---- log: why a call fails ---- */

GLBK_DEF const char *glbk_result_text(glbk_result result)
{
#define GLBK__TEXT(name, text) text "\0"
    const char *s = GLBK_RESULTS(GLBK__TEXT) "unknown result";
#undef GLBK__TEXT
    unsigned i;
    for (i = 0; i < (unsigned)result && i < GLBK_RESULT_COUNT; i++) s += strlen(s) + 1;
    return s;
}

static void glbk__log(const glbk_context *ctx, const char *text)
{
    if (ctx->system.log) ctx->system.log(ctx->system.user, text);
}

/* Logs a text, then a name, and returns the result. */
static glbk_result glbk__fail(const glbk_context *ctx, glbk_result result, const char *text, const char *name)
{
    glbk__message m;
    m.used = 0;
    glbk__message_text(&m, text);
    glbk__message_text(&m, name);
    glbk__log(ctx, m.text);
    return result;
}

/* Logs "TEXT 0x0502": hexadecimal with at least four digits, as GL's constants are known. */
static void glbk__log_constant(const glbk_context *ctx, const char *text, uint32_t value)
{
    char digits[16] = { 0 };
    int at = 15;
    while (value || at > 11) {
        digits[--at] = "0123456789abcdef"[value % 16];
        value /= 16;
    }
    digits[--at] = 'x';
    digits[--at] = '0';
    (void)glbk__fail(ctx, GLBK_ERR_GL, text, digits + at);
}

static glbk__logger glbk__logger_of(const glbk_context *ctx, const char *function)
{
    glbk__logger logger;
    logger.log = ctx ? ctx->system.log : NULL;
    logger.user = ctx ? ctx->system.user : NULL;
    logger.function = function;
    return logger;
}

GLBK__DEF glbk_result glbk__refuse(const glbk_context *ctx, glbk_result result, const char *function,
                                   const char *field, const char *text)
{
    const glbk__logger logger = glbk__logger_of(ctx, function);
    glbk__log_text(&logger, field, text);
    return result;
}

GLBK__DEF glbk_result glbk__refuse_value(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *field, double value, const char *wanted)
{
    const glbk__logger logger = glbk__logger_of(ctx, function);
    glbk__log_value(&logger, field, value, wanted);
    return result;
}

GLBK__DEF glbk_result glbk__refuse_range(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *field, double value, double low, double high)
{
    glbk__message m;
    m.used = 0;
    glbk__message_number(&m, low);
    if (high > low) {
        glbk__message_text(&m, "..");
        glbk__message_number(&m, high);
    }
    return glbk__refuse_value(ctx, result, function, field, value, m.text);
}
