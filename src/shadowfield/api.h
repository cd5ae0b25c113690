/* ---- results ---- */

#define SFIELD_RESULTS(X)                                                                                   \
    X(SFIELD_OK, "ok")                                                                                      \
    X(SFIELD_ERR_ARGUMENT, "a pointer is NULL, or a count or stride is out of range")                       \
    X(SFIELD_ERR_DESC, "a field of a desc is out of range")                                                 \
    X(SFIELD_ERR_INPUT, "the data cannot be used")                                                          \
    X(SFIELD_ERR_ALLOC, "the allocator returned no memory")                                                 \
    X(SFIELD_ERR_MEMORY, "the caller's memory is too small or misaligned")                                  \
    X(SFIELD_ERR_LIMIT, "a size overflows or passes a limit")                                               \
    X(SFIELD_ERR_CANCELLED, "cancelled by the progress callback")                                           \
    X(SFIELD_ERR_ORDER, "this call comes too early, too late or twice")                                     \
    X(SFIELD_ERR_FORMAT, "not a file of this kind, or a damaged one")                                       \
    X(SFIELD_ERR_VERSION, "a file of an unknown version")                                                   \
    X(SFIELD_ERR_MISMATCH, "what was given does not belong together")

typedef enum sfield_result {
#define SFIELD__ENUM(name, text) name,
    SFIELD_RESULTS(SFIELD__ENUM)
#undef SFIELD__ENUM
    SFIELD_RESULT_COUNT
} sfield_result;

SFIELD_DEF const char *sfield_result_text(sfield_result result);
/* Returns a constant string for any value, "unknown result" beyond the list. */

/* ---- page one ---- */

struct sfield_desc;
struct sfield_stats;
struct sfield_scene_desc;
struct sfield_scene_stats;
typedef struct sfield_field sfield_field;   /* what an object hides or a light radiates, around it */
typedef struct sfield_scene sfield_scene;   /* where everything is now */
typedef struct sfield_cache sfield_cache;   /* what points can keep from frame to frame */

typedef struct sfield_mesh {
    const float    *positions;      /* x, y, z of each vertex */
    size_t          vertex_count;
    size_t          vertex_stride;  /* bytes from one vertex to the next, a multiple of 4, >= 12; 0 = 12 */
    const uint32_t *indices;        /* three to a triangle; NULL = indices16, or else 0, 1, 2, ... */
    size_t          index_count;    /* a multiple of 3 (ignored without indices: vertex_count is used) */
    const uint16_t *indices16;      /* in place of indices; not both */
} sfield_mesh;

SFIELD_DEF sfield_result sfield_build(const struct sfield_desc *desc, const sfield_mesh *mesh,
                                      sfield_field **out, struct sfield_stats *stats);
/* Builds the occlusion field of a mesh, once. desc and stats may be NULL. More about it: "fields", below. */

typedef struct sfield_entity {      /* an instance of fields in the world */
    const sfield_field *occlusion;  /* what it hides; NULL = nothing. It must outlive its use by the scene */
    const sfield_field *source;     /* what it radiates; NULL = nothing */
    float transform[16];            /* field space to world: rotation, one scale > 0, translation; 0: none */
    float tint[3];                  /* factor of the source's radiance: 0 0 0 is dark */
    float time;                     /* seconds, of a source with frames */
} sfield_entity;

typedef struct sfield_points {      /* receivers that belong together, neighbours side by side */
    size_t       count;
    const float *positions;         /* x, y, z of each, in the space of `entity`, or in the world */
    size_t       position_stride;   /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const float *normals;           /* unit; 0 0 0: no receiver, its results are 0 */
    size_t       normal_stride;     /* bytes, a multiple of 4, >= 12; 0 = 12 */
    uint32_t     entity;            /* the entity that they lie on, counted from 1, which moves them, and
                                       neither hides nor lights them; 0 = none */
    float       *rgb;               /* three floats a point: the integral of L V cos / pi, which times the
                                       albedo is radiance; NULL = not wanted */
    float       *ambient;           /* one float a point: the integral of V cos / pi; NULL = not wanted */
    float       *gloss;             /* three floats a point, by harmonics: the integral of L V cos (n + 2) /
                                       (2 pi) cos^n (angle to the mirrored view); NULL = not wanted */
    const sfield_field *self;       /* what their own object hides: sfield_build_self; NULL = nothing */
    sfield_cache       *cache;      /* of these points alone, not used for gloss; NULL = nothing is kept */
    const uint8_t      *visible;    /* 0: leave this point out, its results are 0; NULL = all are wanted */
    const float        *views;      /* unit vectors to the eye, in the world, for gloss; 0 0 0 as above */
    size_t              view_stride;        /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const float        *exponents;  /* n of each point's Phong lobe, 1..1000; NULL = no lobes */
    size_t              exponent_stride;    /* bytes, a multiple of 4; 0 = one exponent for all */
} sfield_points;

SFIELD_DEF sfield_result sfield_scene_create(const struct sfield_scene_desc *desc, sfield_scene **out);
SFIELD_DEF sfield_result sfield_scene_entities(sfield_scene *scene, const sfield_entity *entities,
                                               size_t count);
SFIELD_DEF sfield_result sfield_scene_environment(sfield_scene *scene, const float *rgb, uint32_t width,
                                                  uint32_t height, const float rotation[16]);
SFIELD_DEF sfield_result sfield_shade(sfield_scene *scene, const sfield_points *sets, size_t set_count,
                                      struct sfield_scene_stats *stats);
/* A frame: where the entities are now, distant light (once, while it stays), and the light at all points of
   all sets. desc and stats may be NULL. More about each: "scenes", below. */

SFIELD_DEF void sfield_scene_free(sfield_scene *scene);      /* accepts NULL */
SFIELD_DEF void sfield_free(sfield_field *field);            /* accepts NULL; no scene may use the field */

/* ---- memory, threads, progress, messages: the caller's ---- */

typedef struct sfield_allocator {   /* all zero: malloc and free; else both functions */
    void *(*alloc_fn)(size_t bytes, void *user);    /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} sfield_allocator;

typedef void (*sfield_task)(void *context, size_t index);

typedef struct sfield_system {      /* all zero: malloc and free, this thread alone, no progress, no log */
    sfield_allocator allocator;     /* called from the thread that called us */
    void (*parallel_for)(void *user, size_t count, sfield_task task, void *context);
    /* Must call task(context, i) once for each i < count, in any order and on any threads, and return when
       all are done. What is computed does not depend on the threads. */
    int (*progress)(void *user, float fraction);
    /* Called from the thread that called us, fraction 0..1 never falling within a call; not 0 cancels. */
    void (*log)(void *user, const char *message);
    /* Called at most once by a call that fails, from the thread that called us, before it returns: one line
       without a line end that names the function, the field or element, its value and its range. */
    void *user;                     /* given to parallel_for, progress and log */
} sfield_system;
