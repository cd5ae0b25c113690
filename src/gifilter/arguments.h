/* ---- arguments: results, strides, systems, points ---- */

#define GIFILT__MAX_FLOAT 3.40282347e38f
#define GIFILT__MAX_LIGHT 1e30f     /* more counts as 0, so that sums of neighbours stay finite */
#define GIFILT__FAR 3.0e38f

enum {
    GIFILT__SPAN = 64,          /* pixels of a row that are taken at once */
    GIFILT__WIDE = 16           /* lanes of the widest vectors */
};

GIFILT_DEF const char *gifilt_result_text(gifilt_result result)
{
    switch (result) {
#define GIFILT__TEXT(name, text) case name: return text;
    GIFILT_RESULTS(GIFILT__TEXT)
#undef GIFILT__TEXT
    case GIFILT_RESULT_COUNT: break;
    }
    return "unknown result";
}

static inline size_t gifilt__stride(size_t stride, size_t standard) { return stride ? stride : standard; }

/* Returns where a call says why it fails. system may be NULL. */
static inline gifilt__logger gifilt__logger_of(const gifilt_system *system, const char *function)
{
    gifilt__logger log;
    log.log = system ? system->log : NULL;
    log.user = system ? system->user : NULL;
    log.function = function;
    return log;
}

/* Logs "FIELD TEXT" and returns the result, for a call that returns it too. */
static inline gifilt_result gifilt__refuse(const gifilt__logger *log, gifilt_result result, const char *field,
                                           const char *text)
{
    gifilt__log_text(log, field, text);
    return result;
}

/* Returns 1 if a value lies within low..high; otherwise, also if it is not a number, logs it and returns 0.
   */
static inline int gifilt__check_range(const gifilt__logger *log, const char *field, double value, double low,
                                      double high, const char *wanted)
{
    if (value >= low && value <= high) return 1;
    gifilt__log_value(log, field, value, wanted);
    return 0;
}

static inline int gifilt__system_valid(const gifilt__logger *log, const gifilt_system *s)
{
    if (gifilt__allocator_valid(s->allocator.alloc_fn, s->allocator.free_fn)) return 1;
    gifilt__log_text(log, "desc.system.allocator", "has one function of two");
    return 0;
}

static inline gifilt__allocator gifilt__allocator_of(const gifilt_system *s)
{
    return gifilt__allocator_make(s->allocator.alloc_fn, s->allocator.free_fn, s->allocator.user);
}

static inline void gifilt__run(const gifilt_system *s, size_t count, gifilt_task task, void *context)
{
    size_t i;
    if (s->parallel_for) s->parallel_for(s->user, count, task, context);
    else
        for (i = 0; i < count; i++) task(context, i);
}

/* Returns 1 if points can be used, whatever their count; else logs why and returns 0. */
static inline int gifilt__points_valid(const gifilt__logger *log, const gifilt_points *p)
{
    if (!p || !p->positions || !p->normals) {
        gifilt__log_text(log,
                         !p             ? "points"
                         : p->positions ? "points.normals"
                                        : "points.positions",
                         "is NULL");
        return 0;
    }
    if (!gifilt__stride_valid(p->position_stride, 12)) {
        gifilt__log_value(log, "points.position_stride", (double)p->position_stride,
                          "0 or a multiple of 4, at least 12");
        return 0;
    }
    if (gifilt__stride_valid(p->normal_stride, 12)) return 1;
    gifilt__log_value(log, "points.normal_stride", (double)p->normal_stride,
                      "0 or a multiple of 4, at least 12");
    return 0;
}
