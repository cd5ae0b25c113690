/* ---- arguments: results, strides, systems, points ---- */

#define RSM__PI 3.14159265f
#define RSM__MAX_FLOAT 3.40282347e38f

enum {
    RSM__LANES = 8,          /* pixel lights that the kernel takes at once */
    RSM__WIDE = 16,          /* lanes of the widest vectors */
    RSM__BLOCK = 64,         /* pixel lights in one block of arrays */
    RSM__RUN = 1024,         /* pixel lights in one sum */
    RSM__BATCH = 32,         /* receivers of a task */
    RSM__FEW = 128,          /* the most pixel lights of a set that go one by one to a vector of receivers */
    RSM__MAX_SIDE = 4096,
    RSM__MAX_SAMPLES = 1 << 20,
    RSM__MAX_POISSON = 4096
};

RSM_DEF const char *rsm_result_text(rsm_result result)
{
    switch (result) {
#define RSM__TEXT(name, text) case name: return text;
    RSM_RESULTS(RSM__TEXT)
#undef RSM__TEXT
    case RSM_RESULT_COUNT: break;
    }
    return "unknown result";
}

static inline size_t rsm__stride_or(size_t stride, size_t standard) { return stride ? stride : standard; }

/* Returns the address of element i of an array whose elements lie `stride` bytes apart. */
static inline const float *rsm__element_at(const float *base, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)(const void *)base + i * stride);
}

/* Returns element i of an array of three floats each; stride 0 is 12. */
static inline rsm__v3 rsm__vector_at(const float *base, size_t stride, size_t i)
{
    return rsm__v3_load(rsm__element_at(base, rsm__stride_or(stride, 12), i));
}

/* Returns whether a vector is finite and small enough for squares and fourth powers of floats. */
static inline int rsm__is_usable(rsm__v3 v)
{
    return fabsf(v.x) <= 1e9f && fabsf(v.y) <= 1e9f && fabsf(v.z) <= 1e9f;      /* false for NaN */
}

/* Returns where a call says why it fails. system may be NULL. */
static inline rsm__logger rsm__logger_of(const rsm_system *system, const char *function)
{
    rsm__logger log;
    log.log = system ? system->log : NULL;
    log.user = system ? system->user : NULL;
    log.function = function;
    return log;
}

/* Logs that a field is what the text says, as in "map is finished", and returns the result. */
static inline rsm_result rsm__refuse(const rsm__logger *log, rsm_result result, const char *field,
                                     const char *text)
{
    rsm__log_text(log, field, text);
    return result;
}

/* Returns whether a value lies within low..high, and logs the field if it does not. NaN does not. */
static inline int rsm__check_range(const rsm__logger *log, const char *field, double value, double low,
                              double high, const char *wanted)
{
    if (value >= low && value <= high) return 1;
    rsm__log_value(log, field, value, wanted);
    return 0;
}

/* Returns whether a face is one of a map's, and logs it if it is not. */
static inline int rsm__check_face(const rsm__logger *log, uint32_t face, uint32_t count)
{
    if (face < count) return 1;
    rsm__log_bound(log, "face", face, "below", count, "the number of faces");
    return 0;
}

/* Returns whether all three components of a vector are finite and at most `most`, and logs one that is not.
   */
static inline int rsm__check_vector(const rsm__logger *log, const char *field, const float v[3], double most,
                                    const char *wanted)
{
    return rsm__check_range(log, field, (double)v[0], -most, most, wanted) &&
           rsm__check_range(log, field, (double)v[1], -most, most, wanted) &&
           rsm__check_range(log, field, (double)v[2], -most, most, wanted);
}

/* Returns whether a system's allocator is whole or left out, and logs if it is not. */
static inline int rsm__system_valid(const rsm__logger *log, const rsm_system *s)
{
    if (rsm__allocator_valid(s->allocator.alloc_fn, s->allocator.free_fn)) return 1;
    rsm__log_text(log, "system.allocator", "has one of its two functions");
    return 0;
}

static inline rsm__allocator rsm__allocator_of(const rsm_system *s)
{
    return rsm__allocator_make(s->allocator.alloc_fn, s->allocator.free_fn, s->allocator.user);
}

/* Runs count tasks, by the caller's parallel_for if there is one. */
static inline void rsm__run_tasks(const rsm_system *s, size_t count, rsm_task task, void *context)
{
    size_t i;
    if (s->parallel_for) s->parallel_for(s->user, count, task, context);
    else
        for (i = 0; i < count; i++) task(context, i);
}

/* Tells the caller how far the call is, and returns whether the caller cancels it. */
static inline int rsm__cancelled(const rsm_system *s, float fraction)
{
    return s->progress && s->progress(s->user, fraction) != 0;
}

/* Runs count tasks in steps, between which the caller may cancel. begin and end are the fractions of the
   whole call at which this part begins and ends. Returns 0 if the caller cancelled. */
static inline int rsm__run_steps(const rsm_system *s, size_t count, rsm_task task, void *context, float begin,
                                 float end)
{
    size_t step, steps = s->progress ? 16 : 1;
    rsm__batch batch;
    batch.task = task;
    batch.context = context;
    batch.first = 0;
    for (step = 0; step < steps; step++) {
        size_t next = count / steps * (step + 1) + count % steps * (step + 1) / steps;
        if (rsm__cancelled(s, begin + (end - begin) * (float)step / (float)steps)) return 0;
        rsm__run_tasks(s, next - batch.first, rsm__batch_task, &batch);
        batch.first = next;
    }
    return 1;
}

/* Returns whether a stride is in range, and logs the field if it is not. */
static inline int rsm__check_stride(const rsm__logger *log, const char *field, size_t stride,
                                      size_t standard)
{
    if (rsm__stride_valid(stride, standard)) return 1;
    rsm__log_value(log, field, (double)stride,
                   standard == 12 ? "0 or a multiple of 4 from 12 on" : "0 or a multiple of 4 from 4 on");
    return 0;
}

/* Returns whether a normal is one that arrays may hold: unit, 0 0 0, or not finite. */
static inline int rsm__unit_or_none(const float n[3])
{
    const float length2 = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    if (rsm__is_unit2(length2)) return 1;
    return (n[0] == 0.0f && n[1] == 0.0f && n[2] == 0.0f) || !(length2 <= RSM__MAX_FLOAT);
}

/* Logs that normal i of an array is not unit, and returns the result. */
static inline rsm_result rsm__refuse_normal(const rsm__logger *log, const char *array, size_t i, rsm__v3 n)
{
    rsm__log_element(log, array, i, "has the length", (double)rsm__v3_length(n), "1 (0.97..1.03), or 0");
    return RSM_ERR_INPUT;
}

/* Returns 1 if all of `count` normals, `stride` floats apart, are unit, as is the rule. Returns 0 if each has
   to be looked at by itself, since 0 0 0 and normals that are not finite are allowed too. Keeps the least and
   the largest of four lengths apart, so that one comparison need not wait for the one before. */
static inline int rsm__all_unit(const float *n, size_t stride, size_t count)
{
    float low[4] = { 1, 1, 1, 1 }, high[4] = { 1, 1, 1, 1 };
    size_t i, l;
    for (i = 0; i + 4 <= count; i += 4)
        for (l = 0; l < 4; l++, n += stride) {
            float length2 = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
            low[l] = length2 < low[l] ? length2 : low[l];
            high[l] = length2 > high[l] ? length2 : high[l];
        }
    for (l = 0; l < 4; l++)
        if (low[l] < RSM__UNIT_LEAST2 || high[l] > RSM__UNIT_MOST2) return 0;
    return i == count;
}

/* Checks the normals of receivers, 64 at a time, and logs the first that is not unit. */
static inline rsm_result rsm__normals_check(const rsm__logger *log, const rsm_points *p)
{
    const size_t stride = rsm__stride_or(p->normal_stride, 12) / 4, block = 64;
    size_t i, k, count = p->indices ? p->index_count : p->count;
    for (i = 0; i < count; i += block) {
        const size_t end = count - i < block ? count : i + block;
        if (!p->indices && rsm__all_unit(p->normals + i * stride, stride, end - i)) continue;
        for (k = i; k < end; k++) {
            const size_t at = p->indices ? p->indices[k] : k;
            const float *n = p->normals + at * stride;
            if (!rsm__unit_or_none(n)) return rsm__refuse_normal(log, "points.normals", at, rsm__v3_load(n));
        }
    }
    return RSM_OK;
}

/* Checks pointers, strides and indices of receivers, then the lengths of their normals. */
static inline rsm_result rsm__points_check(const rsm__logger *log, const rsm_points *p, const float *out)
{
    const rsm_result bad = RSM_ERR_ARGUMENT;
    size_t i, bytes;
    if (!p) return rsm__refuse(log, bad, "points", "is NULL");
    if (p->count && !p->positions) return rsm__refuse(log, bad, "points.positions", "is NULL");
    if (p->count && !p->normals) return rsm__refuse(log, bad, "points.normals", "is NULL");
    if (p->count && !out) return rsm__refuse(log, bad, "irradiance", "is NULL");
    if (!rsm__check_stride(log, "points.position_stride", p->position_stride, 12)) return bad;
    if (!rsm__check_stride(log, "points.normal_stride", p->normal_stride, 12)) return bad;
    if (!rsm__check_stride(log, "points.open_stride", p->open_stride, 4)) return bad;
    if (!rsm__mul_size(p->count, 12, &bytes)) {
        rsm__log_value(log, "points.count", (double)p->count, "less: size_t cannot count the bytes");
        return RSM_ERR_LIMIT;
    }
    for (i = 0; p->indices && i < p->index_count; i++)
        if (p->indices[i] >= p->count) {
            rsm__log_element(log, "points.indices", i, "is", p->indices[i], "below points.count");
            return RSM_ERR_INPUT;
        }
    return p->count ? rsm__normals_check(log, p) : RSM_OK;
}

/* Loads receiver i. Returns 0 if it is none: its normal is 0 0 0, or it is not finite, which *bad counts. */
static inline int rsm__load_receiver(const rsm_points *p, size_t i, rsm__v3 *x, rsm__v3 *n, uint64_t *bad)
{
    *x = rsm__vector_at(p->positions, p->position_stride, i);
    *n = rsm__vector_at(p->normals, p->normal_stride, i);
    if (n->x == 0.0f && n->y == 0.0f && n->z == 0.0f) return 0;
    if (rsm__is_usable(*x) && rsm__is_usable(*n)) return 1;
    ++*bad;
    return 0;
}

static inline float rsm__mean3(const float *rgb) { return (rgb[0] + rgb[1] + rgb[2]) * (1.0f / 3.0f); }
static inline float rsm__fraction(float x) { return x - floorf(x); }
