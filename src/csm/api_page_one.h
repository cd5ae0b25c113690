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
struct cohsm_mesh;                  /* the object's triangles */
struct cohsm_query;                 /* points, and the light of each */
struct cohsm_instance;              /* an object of a scene: maps, and where the object stands */
struct cohsm_desc;                  /* which maps a build makes: see "settings of a build" below */
struct cohsm_stats;                 /* what a build counted: see there */

#ifndef COHSM_WITHOUT_BUILD
COHSM_DEF cohsm_result cohsm_build(const struct cohsm_desc *desc, const struct cohsm_mesh *mesh,
                                   cohsm_maps **out, struct cohsm_stats *stats);
/* Renders the shadow maps of a mesh from all directions or positions of the desc and compresses them.
   desc     NULL = all defaults: 128 x 128 directions, each map 128 x 128 pixels
   out      receives the maps, on COHSM_OK only; give them back by cohsm_free
   stats    may be NULL; receives what the build counted, on COHSM_OK only
   Errors   COHSM_ERR_ARGUMENT (NULL, a stride, a count of corners that is 0 or no multiple of 3, both kinds
            of indices), COHSM_ERR_DESC, COHSM_ERR_INPUT (an index beyond vertex_count, no usable triangle, a
            location), COHSM_ERR_LIMIT (2^31 corners, maps of 4 GiB), COHSM_ERR_ALLOC, COHSM_ERR_CANCELLED
   Cost     Time grows with maps x (triangles + pixels). The memory needed is the sum of these, for N maps of
            M pixels a side, of which a shard has n pixels (M^2 without shards): at most 100 bytes a triangle
            at first, then 40 (44 with a mask); 32 views of 4 M^2 bytes (Z1Z2) or 8 M^2, if M is at most 128
            64 views (with a parallel_for 128); 800,000 (with a parallel_for 1,500,000); 80 n; 4 N (20 N with
            locations); 16 bytes a segment of the last 65,536 maps; and twice the block. While defaults of
            order and orientation are tried, up to 34 MB and 20 M^2 come on top. For COHSM_LAYOUT_FAST the
            trays do, and while they are made what cohsm_open_as says */
#endif

COHSM_DEF cohsm_result cohsm_visible(const cohsm_maps *maps, const struct cohsm_query *query, float *visible,
                                     size_t *refused);
/* Writes for each point whether the object lets the point's light through. Points and lights are in the
   object's space.
   visible  receives query->count floats: 1 lit, 0 shadowed, between them with COHSM_FILTER_PCF, or
            COHSM_REFUSED. A point or light that is not finite, and a direction of length 0, give 1, since
            nothing is known about them
   refused  may be NULL; receives how many points were given COHSM_REFUSED
   Errors   COHSM_ERR_ARGUMENT (NULL, a stride), COHSM_ERR_DESC (light_kind, filter, bias),
            COHSM_ERR_MISMATCH (these maps cannot answer this kind of light). The log is that of the system
            that the maps were made with
   Cost     About one cache miss for each point; with PCF 2^(d + 2) of them, d being the dimensions of the
            domain. Any number of threads may ask the same maps */

COHSM_DEF cohsm_result cohsm_visible_scene(const struct cohsm_instance *instances, size_t instance_count,
                                           const struct cohsm_query *query, float *visible, size_t *refused);
/* Writes the same for a scene of several objects: for each point the product of what each object lets through
   (section 4.6). Points and lights are in world space. The object that a point lies on is asked first; the
   others follow in the order of the list while some light is left. The first object that refuses the light
   decides: the answer is COHSM_REFUSED then. Instance i draws the random numbers of COHSM_FILTER_ROULETTE as
   if it were asked alone with the seed query->seed + i * 0x9e3779b9.
   instances  may be NULL if instance_count is 0: every point is lit then
   Errors     those of cohsm_visible; COHSM_ERR_ARGUMENT also for instances without maps, COHSM_ERR_INPUT
              (a transform that shears, mirrors or scales unevenly), COHSM_ERR_LIMIT (2^32 - 1 instances or
              more). The log is that of the first maps of the scene; a scene without maps has none
   Cost       that of cohsm_visible for each instance whose bounding sphere the way to the light meets, and
              for any other instance some 25 instructions for 8 points (16 with AVX-512). Spheres are tested
              if the lights are directions or positions and there are four instances or more; but
              maps with self_only, and maps of so few directions that a cell is a radian wide (5 x 2, with PCF
              or ROULETTE 9 x 4), are asked by every direction */

COHSM_DEF void cohsm_free(cohsm_maps *maps);
/* Gives back the maps and their memory. NULL is allowed. */

COHSM_DEF const char *cohsm_result_text(cohsm_result result);
/* Returns a constant string that says what a result means; "unknown result" for a number that is none. */

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

#ifndef COHSM_WITHOUT_BUILD
typedef int (*cohsm_mask_fn)(void *user, uint32_t triangle, const float weights[3]);
/* A function of yours that says whether a triangle is there: not 0, or 0 in a hole of its alpha mask. The
   weights of the triangle's corners, which add up to 1, say at which point. parallel_for's threads call the
   function. */

typedef struct cohsm_mesh {
    const float    *positions;      /* x, y, z of each vertex */
    size_t          vertex_count;
    size_t          vertex_stride;  /* bytes from one vertex to the next, a multiple of 4, >= 12; 0 = 12 */
    const uint32_t *indices;        /* three to a triangle; NULL = indices16, or else 0, 1, 2, ... */
    size_t          index_count;    /* a multiple of 3 (ignored without indices: vertex_count is used) */
    const uint16_t *indices16;      /* in place of indices; not both */
    cohsm_mask_fn   mask_fn;        /* holes of an alpha mask, asked for at centres of pixels; NULL = none. A
                                       mesh with a mask is drawn without vectors, and of triangles with the
                                       same corners the first one's mask counts */
    void           *user;           /* given to mask_fn */
} cohsm_mesh;
#endif

typedef enum cohsm_light_kind {     /* what the lights of a query are */
    COHSM_LIGHT_DEFAULT,            /* = COHSM_LIGHT_DIRECTION */
    COHSM_LIGHT_DIRECTION = COHSM_LIGHT_DEFAULT,    /* a light is the direction to it, x, y, z of any length.
                                       The maps must be maps of directions, LATLONG or OCTAHEDRAL */
    COHSM_LIGHT_POSITION,           /* a light is a position x, y, z near by, outside the convex hull of every
                                       object (a semi-local light, section 4.3). The maps must be maps of
                                       directions */
    COHSM_LIGHT_PARAMETER,          /* a light is d parameters in 0..1 (floats; others are clamped), which the
                                       domain of the maps takes to a place or a direction. The domain may be
                                       any but LIST */
    COHSM_LIGHT_INDEX,              /* a light is the number of a map, a uint32_t. The domain may be any; a
                                       point with a number beyond the maps is lit */
    COHSM_LIGHT_COUNT
} cohsm_light_kind;

typedef enum cohsm_filter {         /* how many maps and pixels answer for a point */
    COHSM_FILTER_DEFAULT,           /* = COHSM_FILTER_NEAREST */
    COHSM_FILTER_NEAREST = COHSM_FILTER_DEFAULT,    /* the nearest map, and its nearest pixel: 0 or 1 */
    COHSM_FILTER_PCF,               /* percentage closer filtering: 4 pixels of each of the 2^d nearest maps,
                                       weighted by distance: 0..1 (section 4.5) */
    COHSM_FILTER_ROULETTE,          /* Russian roulette: one of the pixels of PCF at random, with its weight
                                       as its probability: 0 or 1, and in the mean what PCF gives */
    COHSM_FILTER_COUNT
} cohsm_filter;

#define COHSM_REFUSED (-1.0f)       /* the answer if a light stands inside an object's convex hull: maps of
                                       directions see an object from outside only. The hull is kept as a k-DOP
                                       (see "Conventions"), so that a light just outside the true hull may be
                                       refused too */

typedef struct cohsm_query {        /* points and lights; zero it, then set what you care about */
    size_t           count;         /* of receivers */
    const float     *positions;     /* x, y, z of each receiver: world space, or object space for
                                       cohsm_visible */
    size_t           position_stride;   /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const void      *lights;        /* one light for each receiver, of the type that light_kind says */
    size_t           light_stride;  /* bytes from one light to the next, a multiple of 4; 0 = packed: 12 for
                                       DIRECTION and POSITION, 4 d for PARAMETER, 4 for INDEX. The coords of
                                       lightsampling.h are parameters that lie 12 bytes apart */
    int              one_light;     /* not 0: lights holds one light, that of all receivers. Such queries are
                                       much faster with NEAREST, twice that if receivers are
                                       sorted along a curve, unless the light is a POSITION */
    cohsm_light_kind light_kind;
    cohsm_filter     filter;
    float            bias;          /* receivers count as nearer to the light by this many pixels of a map,
                                       lest surfaces shadow themselves; 0 = 1, negative = none */
    uint32_t         seed;          /* of COHSM_FILTER_ROULETTE: receiver i draws its numbers from seed, i
                                       and the instance */
    const uint32_t  *entities;      /* the instance that each receiver lies on, counted from 1, which is asked
                                       first; 0 or a number beyond the list = none. NULL = all none. Ignored
                                       by cohsm_visible */
} cohsm_query;

typedef struct cohsm_instance {     /* an object of a scene; several may share maps */
    const cohsm_maps *maps;
    float transform[16];            /* object to world: a rotation, one scale > 0, a translation; all zero =
                                       the identity */
} cohsm_instance;

typedef struct cohsm_sight {        /* what cohsm_see asks: a scene of objects about a list of lights */
    const cohsm_instance *instances;    /* as for cohsm_visible_scene; several threads ask them */
    size_t      instance_count;
    cohsm_query query;              /* of it light_kind, lights, light_stride, filter, bias and seed. Light
                                       number n is element n of query.lights; if lights is NULL and light_kind
                                       COHSM_LIGHT_INDEX, the light has map n */
} cohsm_sight;

COHSM_DEF void cohsm_see(void *sight, const float position[3], const float normal[3],
                         const uint32_t *numbers, size_t count, float *visible);
/* Writes how much of each of these lights one receiver sees, as cohsm_visible_scene does. The function is an
   rsm_visible_fn of rsm.h and an ism_visible_fn of ism.h: set it there, so that bounced light has shadows
   from these maps. Any number of threads may call it at once.
   sight    a cohsm_sight
   normal   not read
   numbers  numbers of lights
   visible  count floats in 0..1. 1 where COHSM_REFUSED is the answer, since nothing is known there; 0
            for all where cohsm_visible_scene fails, which the log of the maps is told
   Pointers must not be NULL, and sight->query.lights must have all lights whose numbers are given: neither is
   checked.
   Cost     that of cohsm_visible_scene for count points */

COHSM_DEF void cohsm_light_locations(const float *positions, size_t position_stride, const float *normals,
                                     size_t normal_stride, size_t count, float lift, float *locations);
/* Writes cohsm_domain.locations of maps for lights that lie on surfaces, such as the texels of a reflective
   shadow map: with COHSM_DOMAIN_LIST light n has map n then.
   positions   x, y, z of each light, position_stride bytes apart; 0 = 12
   normals     unit, of the surfaces; normal_stride bytes apart, 0 = 12
   lift        how far maps stand above the surfaces, lest these hide all; a hundredth of a unit or so
   locations   receives 4 floats for each light: x, y, z, 1
   Pointers must not be NULL and strides be multiples of 4: neither is checked. */
