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

/* Logs that a field has a value which is out of its range, and returns the result. */
static envsh_result envsh__refuse(const envsh__logger *logger, const char *field, double value,
                                  const char *wanted, envsh_result result)
{
    envsh__log_value(logger, field, value, wanted);
    return result;
}

/* Logs that there is no map of a light. */
static envsh_result envsh__refuse_light(const envsh__logger *logger, uint32_t light, uint32_t count)
{
    envsh__log_bound(logger, "light", light, "below", count, "the count of the last begin");
    return ENVSH_ERR_ARGUMENT;
}

/* Logs that a field is what the text says, as in "mesh is NULL", and returns the result. */
static envsh_result envsh__refuse_text(const envsh__logger *logger, const char *field, const char *text,
                                       envsh_result result)
{
    envsh__log_text(logger, field, text);
    return result;
}

static envsh_result envsh__refuse_no_depth(const envsh__logger *logger)
{
    return envsh__refuse_text(logger, "maps", "were made with desc.no_depth: they have no texels",
                              ENVSH_ERR_MISMATCH);
}

/* Returns whether elements of three floats may lie so many bytes apart; 0 says that they are packed. */
static int envsh__stride_fits(size_t stride) { return stride == 0 || (stride >= 12 && stride % 4 == 0); }

/* Logs that a stride of elements of three floats is out of range, and returns the result. */
static envsh_result envsh__refuse_stride(const envsh__logger *logger, const char *field, size_t stride)
{
    return envsh__refuse(logger, field, (double)stride, "0, or a multiple of 4 from 12 on",
                         ENVSH_ERR_ARGUMENT);
}

/* Returns element i of an array of three floats each. */
static envsh__v3 envsh__load_item(const float *base, size_t stride, size_t i)
{
    return envsh__v3_load((const float *)(const void *)((const char *)base + i * (stride ? stride : 12)));
}

/* Returns whether the vector counts as unit: lengths from 0.97 to 1.03 do, since normals of 8 bits a channel
   have such lengths. */
static int envsh__is_unit(envsh__v3 v)
{
    return envsh__is_unit2(envsh__v3_dot(v, v));
}
