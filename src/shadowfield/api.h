/* ---- page one: soft shadows of objects that move ---- */

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

typedef struct sfield_field sfield_field;   /* what is seen of an object or light, from points all round */
typedef struct sfield_scene sfield_scene;   /* where objects and lights are now, and the environment */
typedef struct sfield_cache sfield_cache;   /* what a set of points keeps from frame to frame */
struct sfield_mesh;                 /* triangles: below, as are entities and points */
struct sfield_entity;               /* an object or light at its place */
struct sfield_points;               /* receivers: the points to be lit, and where results go */
struct sfield_desc;                 /* how fine a field is: ---- fields ---- */
struct sfield_stats;                /* what a build counted: ---- fields ---- */
struct sfield_scene_desc;           /* which fields a scene takes: ---- scenes ---- */
struct sfield_scene_stats;          /* what a frame counted: ---- scenes ---- */

#ifndef SFIELD_WITHOUT_BUILD
SFIELD_DEF sfield_result sfield_build(const struct sfield_desc *desc, const struct sfield_mesh *mesh,
                                      sfield_field **out, struct sfield_stats *stats);
/* Builds the occlusion field of a mesh: once for each object, before the first frame or in a tool.
   desc     NULL = all defaults; stats may be NULL too
   out      the field, which sfield_free takes back; written on SFIELD_OK only
   Errors   SFIELD_ERR_DESC, SFIELD_ERR_ARGUMENT (NULL, a stride, the index count, both kinds of indices),
            SFIELD_ERR_INPUT (an index beyond vertex_count, no triangle left), SFIELD_ERR_ALLOC,
            SFIELD_ERR_LIMIT, SFIELD_ERR_CANCELLED
   Cost     shells x 6 side^2 views of all triangles, and as many again inside the mesh: of 10,000 triangles
            seconds (harmonics) to minutes (wavelets). Memory: 12 bytes a vertex, 52 a triangle, 3 MB */
#endif

SFIELD_DEF sfield_result sfield_scene_create(const struct sfield_scene_desc *desc, sfield_scene **out);
/* Makes an empty scene, which sfield_scene_free takes back. desc NULL = all defaults: harmonics of 4 bands.
   Errors   SFIELD_ERR_DESC, SFIELD_ERR_ARGUMENT (out is NULL), SFIELD_ERR_ALLOC */

SFIELD_DEF sfield_result sfield_scene_entities(sfield_scene *scene, const struct sfield_entity *entities,
                                               size_t count);
/* Tells the scene where all objects and lights are now, by a list that replaces the one before. Call it in
   each frame in which something has moved. The list (count 0..65535) is copied, its fields are not.
   Errors   SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_INPUT (a transform that is not a rotation with one scale
            and a translation, a tint beyond -1e18..1e18, a time that is not finite; with desc.strict: an
            overlap), SFIELD_ERR_MISMATCH (a field whose basis, bands, cube_side or kind does not suit the
            scene, or that is a shard; SFIELD_PRODUCT_SPARSE: a rotated entity that hides or shines),
            SFIELD_ERR_LIMIT (count), SFIELD_ERR_ALLOC. The scene then keeps the list that it had */

SFIELD_DEF sfield_result sfield_shade(sfield_scene *scene, const struct sfield_points *sets, size_t set_count,
                                      struct sfield_scene_stats *stats);
/* Computes the direct light that reaches every point of all sets, entities taken from near to far (figure 5
   of the paper), and writes it to the arrays that the sets name. stats may be NULL.
   Results are not clamped: the ringing of harmonics may take them below 0. A surface that faces a sun is 25 %
   too dark with 2 bands, and 6 % too bright with 3 or 4. Points that are not finite get 0.
   Errors   SFIELD_ERR_ARGUMENT (NULL, a stride, gloss without to_eye, materials beside exponents or ambient),
            SFIELD_ERR_INPUT (a normal or to_eye that is not unit, a material out of range, an entity beyond
            the list), SFIELD_ERR_MISMATCH (a self-visibility or cache of another basis or count;
            SFIELD_PRODUCT_SPARSE: a self-visibility on a rotated entity),
            SFIELD_ERR_LIMIT (2^31 points in a set), SFIELD_ERR_ALLOC
   Cost     with harmonics about 0.1 us for each pair of a point and an occluder in reach */

SFIELD_DEF sfield_result sfield_scene_environment(sfield_scene *scene, const float *rgb, uint32_t width,
                                                  uint32_t height, const float to_world[16]);
/* Sets the distant light, and takes all suns away. Call it once: the scene keeps a cube map made from it.
   rgb       radiance in W/(sr m^2), 3 floats for each of width x height (1..65536) texels of a
             latitude-longitude map: the first row looks to +Y, the centre to +X, and +Z lies right of it.
             NULL = no environment. What is negative or not finite counts as 0, more than 1e18 as 1e18.
             Each texel is one radiance over its exact solid angle
   to_world  a rotation from the map's space to the world; NULL or all 0 = none
   Errors    SFIELD_ERR_ARGUMENT (scene is NULL, which leaves no log; width or height is out of range),
             SFIELD_ERR_INPUT (to_world is no rotation), SFIELD_ERR_ALLOC */

SFIELD_DEF void sfield_scene_free(sfield_scene *scene);
/* Takes back a scene and its memory. Accepts NULL. */

SFIELD_DEF void sfield_free(sfield_field *field);
/* Takes back a field and its memory. No scene may use the field any more. Accepts NULL. */

SFIELD_DEF const char *sfield_result_text(sfield_result result);
/* Returns a constant string for any value, "unknown result" beyond the list. */

/* ---- structs of page one ---- */

#ifndef SFIELD_WITHOUT_BUILD
typedef int (*sfield_mask_fn)(void *user, uint32_t triangle, const float weights[3]);
/* A function of yours that says whether a triangle is there: not 0, or 0 in a hole of its alpha mask. The
   weights of the triangle's corners, which add up to 1, say at which point. parallel_for's threads call the
   function. */

typedef struct sfield_mesh {
    const float    *positions;      /* x, y, z of each vertex */
    size_t          vertex_count;
    size_t          vertex_stride;  /* bytes from one vertex to the next, a multiple of 4, >= 12; 0 = 12 */
    const uint32_t *indices;        /* three to a triangle; NULL = indices16, or else 0, 1, 2, ... */
    size_t          index_count;    /* a multiple of 3 (ignored without indices: vertex_count is used) */
    const uint16_t *indices16;      /* in place of indices; not both */
    sfield_mask_fn  mask_fn;        /* holes of an alpha mask, asked for at each sample of a view, of which a
                                       texel has many; NULL = none */
    void           *user;           /* given to mask_fn */
} sfield_mesh;
#endif

typedef struct sfield_entity {      /* an instance of fields in the world: an object, a light, or both */
    const sfield_field *occlusion;  /* what the entity hides; NULL = nothing. The field must outlive its use
                                       by the scene, as must `source` */
    const sfield_field *source;     /* what the entity radiates; NULL = nothing */
    float transform[16];            /* matrix from the fields' space to the world: rotation, one scale > 0,
                                       translation. All 0: the identity */
    float tint[3];                  /* factors of the source's r, g and b; 0 0 0: the light is off */
    float time;                     /* seconds, finite, which choose between the frames of a source; other
                                       fields have no frames */
} sfield_entity;

typedef struct sfield_points {      /* receivers that belong together, neighbours side by side */
    size_t       count;             /* below 2^31 */
    const float *positions;         /* x, y, z of each, in the space of `entity`, or in the world */
    size_t       position_stride;   /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const float *normals;           /* unit; 0 0 0: no receiver, its results are 0 */
    size_t       normal_stride;     /* bytes, a multiple of 4, >= 12; 0 = 12 */
    uint32_t     entity;            /* number of the entity that the points lie on, counted from 1. Its
                                       transform moves them, and it neither hides nor lights them. 0 = none */
    float       *rgb;               /* results, 3 floats a point, W/(sr m^2): the integral of L V cos / pi,
                                       which times the albedo is the radiance of a diffuse surface. NULL =
                                       not wanted */
    float       *ambient;           /* results, a float a point, 0..1: the integral of V cos / pi. NULL = not
                                       wanted */
    float       *gloss;             /* results, 3 floats a point. By exponents: the integral of L
                                       V cos (n + 2) / (2 pi) cos^n (angle to the mirrored view). By
                                       materials: of L V cos F D G / (4 (n . l) (n . v)), the specular part of
                                       glTF's metal-rough BRDF. NULL = not wanted */
    const sfield_field *self;       /* what the points' own object hides, from sfield_build_self; NULL =
                                       nothing */
    sfield_cache       *cache;      /* of these points alone, from sfield_cache_create. NULL = nothing is
                                       kept */
    const uint8_t      *in_view;    /* a byte a point; 0: the point is left out, its results are 0. NULL = all
                                       are wanted */
    const float        *to_eye;     /* for gloss, the direction from each point to the eye: unit, three
                                       floats, in the world. 0 0 0: all results of the point are 0 */
    size_t              to_eye_stride;      /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const float        *exponents;  /* for gloss, n of each point's Phong lobe, 1..1000; without exponents and
                                       materials gloss is 0 */
    size_t              exponent_stride;    /* bytes, a multiple of 4; 0 = one exponent for all */
    const float        *materials;  /* for gloss in place of exponents: base colour r, g, b, metallic and
                                       roughness of each point, 0..1, as in glTF 2.0, appendix B. rgb has a
                                       factor 1 - F under its integral then, so that the surface sends base (1
                                       - metallic) rgb + gloss to the eye. Takes no ambient */
    size_t              material_stride;    /* bytes, a multiple of 4, >= 20; 0 = one material for all */
    float              *grazing;    /* results with gloss and materials, 3 floats a point: the part of gloss
                                       that F0, which is 0.04 + (base - 0.04) metallic, does not color. By it
                                       a texture can: for its F0', gloss is (gloss - grazing) F0' / F0 +
                                       grazing, and rgb has the factor (1 - F0') / (1 - F0). NULL = not
                                       wanted */
} sfield_points;

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
