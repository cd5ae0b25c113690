/* ---- services: texts of results, the caller's allocator and log ---- */

SFIELD_DEF const char *sfield_result_text(sfield_result result)
{
    static const char *const texts[] = {
#define SFIELD__TEXT(name, text) text,
        SFIELD_RESULTS(SFIELD__TEXT)
#undef SFIELD__TEXT
    };
    return (uint32_t)result < SFIELD_RESULT_COUNT ? texts[result] : "unknown result";
}

static sfield__allocator sfield__allocator_of(const sfield_system *system)
{
    const sfield_allocator *a = system ? &system->allocator : NULL;
    return a ? sfield__allocator_make(a->alloc_fn, a->free_fn, a->user)
             : sfield__allocator_make(NULL, NULL, NULL);
}

/* Returns whether an allocator has both of its functions, or none. */
static int sfield__system_good(const sfield_system *system)
{
    return !system || sfield__allocator_valid(system->allocator.alloc_fn, system->allocator.free_fn);
}

static sfield__logger sfield__logger_of(const sfield_system *system, const char *function)
{
    sfield__logger log;
    log.log = system ? system->log : NULL;
    log.user = system ? system->user : NULL;
    log.function = function;
    return log;
}

/* Returns the log that an object keeps, for a function that is called with the object. */
static sfield__logger sfield__logger_for(const sfield__logger *kept, const char *function)
{
    sfield__logger log = *kept;
    log.function = function;
    return log;
}

/* Returns the result with which a call fails, once its line is written. */
static SFIELD__COLD sfield_result sfield__fail(const sfield__logger *log, sfield_result result,
                                               const char *field, const char *text)
{
    sfield__log_text(log, field, text);
    return result;
}

static SFIELD__COLD sfield_result sfield__fail_null(const sfield__logger *log, const char *argument)
{
    return sfield__fail(log, SFIELD_ERR_ARGUMENT, argument, "is NULL");
}

static SFIELD__COLD sfield_result sfield__fail_allocator(const sfield__logger *log)
{
    return sfield__fail(log, SFIELD_ERR_DESC, "system.allocator",
                        "has one of its functions without the other");
}

/* Writes the line "FUNCTION: ARRAY[INDEX] TEXT" and returns the result. */
static SFIELD__COLD sfield_result sfield__fail_at(const sfield__logger *log, sfield_result result,
                                                  const char *array, uint64_t index, const char *text)
{
    sfield__message m;
    if (!log->log) return result;
    sfield__message_begin(&m, log, array);
    sfield__message_text(&m, "[");
    sfield__message_count(&m, index);
    sfield__message_text(&m, "] ");
    sfield__message_text(&m, text);
    log->log(log->user, m.text);
    return result;
}

/* Returns whether a setting is in its range, as `good` says. If the setting is not, a line says so. */
static int sfield__check_value(const sfield__logger *log, int good, const char *field, double value,
                        const char *range)
{
    if (!good) sfield__log_value(log, field, value, range);
    return good;
}

/* Returns what a vector of an array is: 1 unit, 0 left out (zero, or not finite), -1 neither: an error. */
static int sfield__unit_vector(const float *v)
{
    const float nn = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (sfield__is_unit2(nn)) return 1;
    return sfield__finite(nn) && nn > 0 ? -1 : 0;
}

/* Fails with the first vector of an array that has another length. */
static sfield_result sfield__check_units(const sfield__logger *log, const char *array, const float *vectors,
                                         size_t stride, size_t count)
{
    const char *at = (const char *)(const void *)vectors;
    size_t i;
    for (i = 0; i < count; i++, at += stride ? stride : 12) {
        const float *v = (const float *)(const void *)at;
        if (sfield__unit_vector(v) >= 0) continue;
        sfield__log_element(log, array, i, "has the length",
                            sqrt((double)(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])), "1 (0.97..1.03), or 0");
        return SFIELD_ERR_INPUT;
    }
    return SFIELD_OK;
}

/* Returns whether planes have room for the vectors of a call. If they have not, a line says so. */
static int sfield__check_stride(const sfield__logger *log, size_t stride, size_t count)
{
    return sfield__check_value(log, stride >= count, "stride", (double)stride, "at least count");
}

/* Returns row i of an array of three floats; a stride of 0 is 12. */
static const float *sfield__row(const float *base, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)(const void *)base + i * (stride ? stride : 12));
}

/* Returns whether positions and normals are there with good strides. If not, a line says what is wrong. */
static int sfield__points_good(const sfield__logger *log, const sfield_points *p)
{
    if (!p->positions || !p->normals) {
        sfield__log_text(log, p->positions ? "points->normals" : "points->positions", "is NULL");
        return 0;
    }
    return sfield__check_value(log, sfield__stride_valid(p->position_stride, 12), "points->position_stride",
                        (double)p->position_stride, "0, or a multiple of 4 of at least 12") &&
           sfield__check_value(log, sfield__stride_valid(p->normal_stride, 12), "points->normal_stride",
                        (double)p->normal_stride, "0, or a multiple of 4 of at least 12");
}

/* Returns the power of two that brings x > 0 to 1 or just above: squares stay in range, bits the same. */
static float sfield__unit(float x)
{
    uint32_t e = sfield__to_bits(x) >> 23;
    e = e < 1u ? 1u : e > 253u ? 253u : e;
    return sfield__from_bits((254 - e) << 23);
}

/* ---- vectors: sixteen floats at a time ---- */

#if defined(__GNUC__) || defined(__clang__)
#define SFIELD__INLINE static inline __attribute__((always_inline))
#else
#define SFIELD__INLINE static inline
#endif

enum {
    SFIELD__LANES = 16,             /* points that are treated at a time */
    SFIELD__STAGED = 300,           /* pairs of coefficients of 5 bands, which a stack holds */
    SFIELD__STAGED_COEFS = 25,      /* coefficients of 5 bands */
    SFIELD__PIECES = 16,            /* tasks that a call is divided into */
    SFIELD__SHARED = 3              /* lanes that the same eight samples must serve, on average */
};

/* The functions below call the kernels of the best instruction set there is, which kernels_end.h chooses. All
   of them work on sixteen lanes. */

/* Writes the product a b, or a - a b if occlude is not 0. */
static void sfield__product16(const sfield_algebra *t, const float *a, const float *b, float *out,
                              size_t stride, int occlude);

static void sfield__rotate16(const sfield_rotation *r, const float *in, float *out, size_t stride,
                             int inverse, int simd);
