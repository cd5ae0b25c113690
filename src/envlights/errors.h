/* ---- errors: results and what is logged of them ---- */

ENVLT_DEF const char *envlt_result_text(envlt_result result)
{
    static const char *const texts[] = {
#define ENVLT__TEXT(name, text) text,
        ENVLT_RESULTS(ENVLT__TEXT)
#undef ENVLT__TEXT
    };
    return (unsigned)result < ENVLT_RESULT_COUNT ? texts[result] : "unknown result";
}

static envlt__logger envlt__make_logger(const envlt_system *system, const char *function)
{
    envlt__logger logger;
    logger.log = system->log;
    logger.user = system->user;
    logger.function = function;
    return logger;
}

/* Logs that a field has a value which is out of its range, and returns the result. */
static envlt_result envlt__refuse(const envlt__logger *logger, const char *field, double value,
                                  const char *wanted, envlt_result result)
{
    envlt__log_value(logger, field, value, wanted);
    return result;
}

/* Returns the result of a call whose arguments were right, and logs if the allocator returned no memory. */
static envlt_result envlt__end_call(const envlt__logger *logger, envlt_result result)
{
    if (result == ENVLT_ERR_ALLOC) envlt__log_text(logger, "system.allocator", "returned no memory");
    return result;
}

/* Logs that a field is what the text says, as in "map is NULL", and returns the result. */
static envlt_result envlt__refuse_text(const envlt__logger *logger, const char *field, const char *text,
                                       envlt_result result)
{
    envlt__log_text(logger, field, text);
    return result;
}
