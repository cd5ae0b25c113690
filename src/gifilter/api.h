/* ---- page one: a filter, and a frame through it ---- */

#define GIFILT_RESULTS(X)                                                                                    \
    X(GIFILT_OK, "ok")                                                                                       \
    X(GIFILT_ERR_ARGUMENT, "a pointer is NULL, or a count or stride is out of range")                        \
    X(GIFILT_ERR_DESC, "a field of a desc is out of range")                                                  \
    X(GIFILT_ERR_INPUT, "the data cannot be used")                                                           \
    X(GIFILT_ERR_ALLOC, "the allocator returned no memory")                                                  \
    X(GIFILT_ERR_MEMORY, "the caller's memory is too small or misaligned")                                   \
    X(GIFILT_ERR_LIMIT, "a size overflows or passes a limit")                                                \
    X(GIFILT_ERR_CANCELLED, "cancelled by the progress callback")                                            \
    X(GIFILT_ERR_ORDER, "this call comes too early, too late or twice")                                      \
    X(GIFILT_ERR_FORMAT, "not a file of this kind, or a damaged one")                                        \
    X(GIFILT_ERR_VERSION, "a file of an unknown version")                                                    \
    X(GIFILT_ERR_MISMATCH, "what was given does not belong together")

typedef enum gifilt_result {
#define GIFILT__ENUM(name, text) name,
    GIFILT_RESULTS(GIFILT__ENUM)
#undef GIFILT__ENUM
    GIFILT_RESULT_COUNT
} gifilt_result;

typedef struct gifilt_filter gifilt_filter; /* what the frames so far knew of each pixel */
struct gifilt_desc;                 /* the size of the pictures */
struct gifilt_points;               /* what each pixel shows */
struct gifilt_frame;                /* the camera and the settings of one frame */

GIFILT_DEF gifilt_result gifilt_create(const struct gifilt_desc *desc, gifilt_filter **out);
/* Makes a filter for pictures of one size, which gifilt_free takes back.
   out      written on GIFILT_OK only
   Errors   GIFILT_ERR_ARGUMENT: desc, which leaves no log, or out is NULL; GIFILT_ERR_DESC: width, height or
            the allocator; GIFILT_ERR_LIMIT: the filter is larger than a size_t counts; GIFILT_ERR_ALLOC */

GIFILT_DEF gifilt_result gifilt_apply(gifilt_filter *filter, const struct gifilt_frame *frame,
                                      const struct gifilt_points *points, const float *light, float *out);
/* Filters the light of one frame, and remembers it for the next.
   frame    NULL = all defaults; the history then starts anew, since no camera is known
   points   what each pixel shows: width x height points, row by row
   light    the noisy irradiance, 3 floats a pixel, up to 1e30; more, and what is not finite, counts as 0
   out      the smooth irradiance, 3 floats a pixel; 0 for a pixel that shows nothing. May be light
   Errors   GIFILT_ERR_ARGUMENT: filter, which leaves no log, or an array is NULL, or a stride is wrong;
            GIFILT_ERR_DESC: a field of the frame; GIFILT_ERR_INPUT: a normal that is not unit;
            GIFILT_ERR_MISMATCH: points->count is not width x height. The filter and out are then as they
            were
   Cost     about 20 ns a pixel with two passes, on one thread; nothing is allocated */

GIFILT_DEF void gifilt_reset(gifilt_filter *filter);
/* Forgets the frames so far, for a cut to another scene. Accepts NULL. */

GIFILT_DEF void gifilt_free(gifilt_filter *filter);
/* Takes back a filter and its memory. Accepts NULL. */

GIFILT_DEF const char *gifilt_result_text(gifilt_result result);
/* Returns a constant string for any value, "unknown result" beyond the list. */

typedef enum gifilt_rows {          /* which row of a picture in memory comes first */
    GIFILT_ROWS_DEFAULT,            /* = GIFILT_ROWS_BOTTOM_FIRST */
    GIFILT_ROWS_BOTTOM_FIRST,       /* the row at clip y = -1, as in OpenGL and Vulkan */
    GIFILT_ROWS_TOP_FIRST,          /* the row at clip y = +1, as in Direct3D and Metal, and in Vulkan with
                                       a viewport of negative height */
    GIFILT_ROWS_COUNT
} gifilt_rows;

typedef struct gifilt_frame {       /* the camera and the settings of one frame */
    const float *world_to_clip;     /* the camera's matrix of this frame, world to clip, 16 floats,
                                       column-major. The next frame finds its surfaces in this one by the
                                       matrix. NULL: the camera is unknown, so that neither this frame nor the
                                       next one has a history unless motion is given */
    const float *motion;            /* where the surface that each pixel shows was in the last frame: x, y in
                                       that frame's pixels, centres at 0.5, rows counted as they lie in
                                       memory. NULL: the surface did not move, and is found by the last
                                       frame's matrix alone */
    gifilt_rows  rows;              /* of the pictures */
    uint32_t     history;           /* frames that count at most, 1..1000. If the light stands still, the
                                       variance of the noise falls to 1 / history; if it moves, the picture
                                       lags behind by as many frames. 0 = 8; 1 = this frame alone */
    int          passes;            /* passes of the a-trous filter over neighbours that are 1, 2, 4, ...
                                       pixels apart, at most 6; 0 = 2, negative = none */
    float        normal_cosine;     /* neighbours count if the cosine of the angle between their normal and
                                       the pixel's is above this number, which is 0 or more and below 1;
                                       0 = 0.9 */
    float        plane_slope;       /* neighbours count if they lie off the pixel's plane by less than this
                                       number, 0..1e6, times their distance; 0 = 0.1 */
} gifilt_frame;

typedef struct gifilt_points {      /* what the pixels show, row by row */
    size_t       count;             /* width x height */
    const float *positions;         /* x, y, z of each, world, up to 1e9; a pixel beyond shows nothing */
    size_t       position_stride;   /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const float *normals;           /* unit; 0 0 0: the pixel shows nothing, its result is 0 */
    size_t       normal_stride;     /* bytes, a multiple of 4, >= 12; 0 = 12 */
} gifilt_points;

/* ---- memory, threads, progress, log: the caller's ---- */

typedef struct gifilt_allocator {   /* all zero: malloc and free; else both functions */
    void *(*alloc_fn)(size_t bytes, void *user);    /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} gifilt_allocator;

typedef void (*gifilt_task)(void *context, size_t index);

typedef struct gifilt_system {      /* all zero: malloc and free, this thread alone, no progress, no log */
    gifilt_allocator allocator;     /* called from the thread that called us */
    void (*parallel_for)(void *user, size_t count, gifilt_task task, void *context);
    /* Must call task(context, i) once for each i < count, in any order and on any threads, and return when
       all are done. What is computed does not depend on the threads. */
    int (*progress)(void *user, float fraction);
    /* Called from the thread that called us, fraction 0..1 never falling within a call; not 0 cancels. This
       header does not call it: a frame takes milliseconds. */
    void (*log)(void *user, const char *message);
    /* Called at most once by a call that fails, from the thread that called us, before it returns: one line
       without a line end that names the function, the field or element, its value and its range. */
    void *user;                     /* given to parallel_for, progress and log */
} gifilt_system;

typedef struct gifilt_desc {        /* what a filter is made for; width and height have no default */
    gifilt_system system;           /* kept: the filter's later calls use it too */
    uint32_t   width, height;       /* of the pictures, 1..65536 */
} gifilt_desc;

#ifdef __cplusplus
}
#endif

#endif /* GIFILTER_H */
