/* ---- errors: results and what is logged of them ---- */

ENVSH_DEF const char *envsh_result_text(envsh_result result)
{
    static const char *const texts[] = {
#define ENVSH__TEXT(name, text) text,
        ENVSH_RESULTS(ENVSH__TEXT)
#undef ENVSH__TEXT
    };
    return (unsigned)result < ENVSH_RESULT_COUNT ? texts[result] : "unknown result";
}

static envsh__logger envsh__make_logger(const envsh_system *system, const char *function)
{
    envsh__logger logger;
    logger.log = system->log;
    logger.user = system->user;
    logger.function = function;
    return logger;
}

/* Logs that a field has a value that it must not have, and returns the result. */
static envsh_result envsh__refuse(const envsh__logger *logger, const char *field, double value,
                                  const char *wanted, envsh_result result)
{
    envsh__log_value(logger, field, value, wanted);
    return result;
}

/* Does the same, with a text in place of the value. */
static envsh_result envsh__refuse_text(const envsh__logger *logger, const char *field, const char *text,
                                       envsh_result result)
{
    envsh__log_text(logger, field, text);
    return result;
}

static int envsh__stride_fits(size_t stride) { return stride == 0 || (stride >= 12 && stride % 4 == 0); }

/* Logs a stride of arrays of three floats, and returns that it cannot be used. */
static envsh_result envsh__refuse_stride(const envsh__logger *logger, const char *field, size_t stride)
{
    return envsh__refuse(logger, field, (double)stride, "0, or a multiple of 4 from 12 on",
                         ENVSH_ERR_ARGUMENT);
}

static envsh__v3 envsh__load_item(const float *base, size_t stride, size_t i)
{
    return envsh__v3_load((const float *)(const void *)((const char *)base + i * (stride ? stride : 12)));
}

/* Says whether the vector counts as unit: its length may lie from 0.97 to 1.03, as 8-bit normal maps make
   them. */
static int envsh__is_unit(envsh__v3 v)
{
    return envsh__is_unit2(envsh__v3_dot(v, v));
}
