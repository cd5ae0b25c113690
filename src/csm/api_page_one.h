/* ---- page one: maps of a mesh, and points that ask them ---- */

#define COHSM_RESULTS(X)                                                                                    \
    X(COHSM_OK, "ok")                                                                                       \
    X(COHSM_ERR_ARGUMENT, "a pointer is NULL, or a count or stride is out of range")                        \
    X(COHSM_ERR_DESC, "a field of a desc is out of range")                                                  \
    X(COHSM_ERR_INPUT, "the data cannot be used")                                                           \
    X(COHSM_ERR_ALLOC, "the allocator returned no memory")                                                  \
    X(COHSM_ERR_MEMORY, "the caller's memory is too small or misaligned")                                   \
    X(COHSM_ERR_LIMIT, "a size overflows or passes a limit")                                                \
    X(COHSM_ERR_CANCELLED, "cancelled by the progress callback")                                            \
    X(COHSM_ERR_ORDER, "this call comes too early, too late or twice")                                      \
    X(COHSM_ERR_FORMAT, "not a file of this kind, or a damaged one")                                        \
    X(COHSM_ERR_VERSION, "a file of an unknown version")                                                    \
    X(COHSM_ERR_MISMATCH, "what was given does not belong together")

typedef enum cohsm_result {
#define COHSM__ENUM(name, text) name,
    COHSM_RESULTS(COHSM__ENUM)
#undef COHSM__ENUM
    COHSM_RESULT_COUNT
} cohsm_result;

typedef struct cohsm_maps cohsm_maps;       /* one object's shadow maps, compressed into one block of bytes */
struct cohsm_mesh;                  /* its triangles */
struct cohsm_query;                 /* points, and the light of each */
struct cohsm_instance;              /* an object of a scene: maps, and where the object stands */
struct cohsm_desc;                  /* which maps are made: ---- settings of a build ---- */
struct cohsm_stats;                 /* what a build counted: ---- settings of a build ---- */

COHSM_DEF cohsm_result cohsm_build(const struct cohsm_desc *desc, const struct cohsm_mesh *mesh,
                                   cohsm_maps **out, struct cohsm_stats *stats);
/* Renders the shadow maps of a mesh from all directions or positions of the desc and compresses them.
   desc     NULL = all defaults: 128 x 128 directions, each map 128 x 128 pixels
   out      written on COHSM_OK only; cohsm_free takes the maps back
   stats    may be NULL; written on COHSM_OK only
   Errors   COHSM_ERR_ARGUMENT, COHSM_ERR_DESC, COHSM_ERR_INPUT (stride, index beyond vertex_count, no usable
            triangle), COHSM_ERR_LIMIT, COHSM_ERR_ALLOC, COHSM_ERR_CANCELLED
   Cost     time grows with maps x (triangles + pixels). Memory, N being the maps, M the pixels a side, n the
            pixels of the shard: at most 100 bytes a triangle at first, then 40; 32 views of 4 M^2 bytes
            (Z1Z2) or 8 M^2; 80 n; 4 N (20 N with locations); 16 bytes a segment of the last 65,536 maps; and
            twice the block. The bytes built do not depend on compiler or threads */

COHSM_DEF cohsm_result cohsm_visible(const cohsm_maps *maps, const struct cohsm_query *query, float *visible,
                                     size_t *refused);
/* Answers for each point whether the object lets its light through. Points and lights are in the object's
   space.
   visible  receives a float for each point: 1 lit, 0 shadowed, in between with COHSM_FILTER_PCF, or
            COHSM_REFUSED
   refused  may be NULL; receives how many points were given COHSM_REFUSED
   Errors   COHSM_ERR_ARGUMENT, COHSM_ERR_DESC, COHSM_ERR_MISMATCH (these maps cannot answer this kind of
            light). Points and lights that are not finite, and directions of length 0, give 1: nothing is
            known there
   Cost     one block of a list, about one cache miss, for each point; with PCF 2^(d + 2) of them, d being
            the dimensions of the domain. Any number of threads may ask the same maps */

COHSM_DEF cohsm_result cohsm_visible_scene(const struct cohsm_instance *instances, size_t instance_count,
                                           const struct cohsm_query *query, float *visible, size_t *refused);
/* Answers the same for a scene of several objects: the product of what each of them lets through (section
   4.6). Points and lights are in world space. The object that a point lies on is asked first, then, while
   some light is left, the others. Instance i draws the random numbers of COHSM_FILTER_ROULETTE as if it were
   asked alone with the seed seed + 0x9e3779b9 i.
   Errors   as cohsm_visible; COHSM_ERR_ARGUMENT also for transforms that shear, mirror or scale unevenly */

COHSM_DEF void cohsm_free(cohsm_maps *maps);
/* Takes back maps and their memory. Accepts NULL. */

COHSM_DEF const char *cohsm_result_text(cohsm_result result);
/* Returns a constant string for any value, "unknown result" beyond the list. */

/* ---- memory, threads, progress, log: the caller's ---- */

typedef struct cohsm_allocator {    /* all zero: malloc and free; else both functions */
    void *(*alloc_fn)(size_t bytes, void *user);    /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} cohsm_allocator;

typedef void (*cohsm_task)(void *context, size_t index);

typedef struct cohsm_system {       /* all zero: malloc and free, this thread alone, no progress, no log */
    cohsm_allocator allocator;      /* called from the thread that called us */
    void (*parallel_for)(void *user, size_t count, cohsm_task task, void *context);
    /* Must call task(context, i) once for each i < count, in any order and on any threads, and return when
       all are done. What is computed does not depend on the threads. */
    int (*progress)(void *user, float fraction);
    /* Called from the thread that called us, fraction 0..1 never falling within a call; not 0 cancels. */
    void (*log)(void *user, const char *message);
    /* Called at most once by a call that fails, from the thread that called us, before it returns: one line
       without a line end that names the function, the field or element, its value and its range. */
    void *user;                     /* given to parallel_for, progress and log */
} cohsm_system;

/* ---- structs of page one ---- */

typedef struct cohsm_mesh {
    const float    *positions;      /* x, y, z of each vertex */
    size_t          vertex_count;
    size_t          vertex_stride;  /* bytes from one vertex to the next, a multiple of 4, >= 12; 0 = 12 */
    const uint32_t *indices;        /* three to a triangle; NULL = indices16, or else 0, 1, 2, ... */
    size_t          index_count;    /* a multiple of 3 (ignored without indices: vertex_count is used) */
    const uint16_t *indices16;      /* in place of indices; not both */
} cohsm_mesh;

typedef enum cohsm_light_kind {     /* what the lights of a query are */
    COHSM_LIGHT_DEFAULT,            /* = COHSM_LIGHT_DIRECTION */
    COHSM_LIGHT_DIRECTION = COHSM_LIGHT_DEFAULT,    /* directions to the light, x, y, z of any length; asks
                                       maps of directions */
    COHSM_LIGHT_POSITION,           /* positions x, y, z of lights near by, which must stand outside the
                                       convex hull of every object (semi-local lights, section 4.3); asks
                                       maps of directions */
    COHSM_LIGHT_PARAMETER,          /* d parameters in 0..1 each, which the domain of the maps takes to a
                                       place or a direction; any domain but LIST */
    COHSM_LIGHT_INDEX,              /* the number of a map, a uint32_t each; any domain. Numbers beyond the
                                       maps count as lit */
    COHSM_LIGHT_COUNT
} cohsm_light_kind;

typedef enum cohsm_filter {         /* how many maps and pixels answer for a point */
    COHSM_FILTER_DEFAULT,           /* = COHSM_FILTER_NEAREST */
    COHSM_FILTER_NEAREST = COHSM_FILTER_DEFAULT,    /* the nearest map, and its nearest pixel: 0 or 1 */
    COHSM_FILTER_PCF,               /* the 2^d nearest maps, 4 pixels of each, weighted by distance: 0..1
                                       (section 4.5) */
    COHSM_FILTER_ROULETTE,          /* one of those at random, its weight being its probability: 0 or 1, with
                                       the mean of PCF */
    COHSM_FILTER_COUNT
} cohsm_filter;

#define COHSM_REFUSED (-1.0f)       /* the answer where a light stands inside an object's hull, which the maps
                                       have not seen from inside */

typedef struct cohsm_query {        /* points and lights; zero it, then set what you care about */
    size_t           count;         /* of receivers */
    const float     *positions;     /* x, y, z of each receiver: world space, or object space for
                                       cohsm_visible */
    size_t           position_stride;   /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const void      *lights;        /* one for each receiver, as light_kind says */
    size_t           light_stride;  /* bytes, a multiple of 4; 0 = packed, which are d floats for PARAMETER.
                                       The coords of lightsampling.h are 12 bytes apart */
    int              one_light;     /* not 0: lights is one element, the light of all receivers. This is much
                                       faster where receivers lie close together */
    cohsm_light_kind light_kind;
    cohsm_filter     filter;
    float            bias;          /* receivers count as nearer to the light by this many pixels of a map,
                                       lest surfaces shadow themselves; 0 = 1, negative = none */
    uint32_t         seed;          /* of COHSM_FILTER_ROULETTE: receiver i draws its numbers from seed, i
                                       and the instance */
    const uint32_t  *entities;      /* the instance that each receiver lies on, counted from 1, which is asked
                                       first; 0 or a number beyond the list = none. NULL = none */
} cohsm_query;

typedef struct cohsm_instance {     /* an object of a scene; several may share maps */
    const cohsm_maps *maps;
    float transform[16];            /* object to world: a rotation, one scale > 0, a translation */
} cohsm_instance;
