/* ---- page one: a light, samples towards it, and their sum ---- */

#define LSAMP_RESULTS(X)                                                                                    \
    X(LSAMP_OK, "ok")                                                                                       \
    X(LSAMP_ERR_ARGUMENT, "a pointer is NULL, or a count or stride is out of range")                        \
    X(LSAMP_ERR_DESC, "a field of a desc is out of range")                                                  \
    X(LSAMP_ERR_INPUT, "the data cannot be used")                                                           \
    X(LSAMP_ERR_ALLOC, "the allocator returned no memory")                                                  \
    X(LSAMP_ERR_MEMORY, "the caller's memory is too small or misaligned")                                   \
    X(LSAMP_ERR_LIMIT, "a size overflows or passes a limit")                                                \
    X(LSAMP_ERR_CANCELLED, "cancelled by the progress callback")                                            \
    X(LSAMP_ERR_ORDER, "this call comes too early, too late or twice")                                      \
    X(LSAMP_ERR_FORMAT, "not a file of this kind, or a damaged one")                                        \
    X(LSAMP_ERR_VERSION, "a file of an unknown version")                                                    \
    X(LSAMP_ERR_MISMATCH, "what was given does not belong together")

typedef enum lsamp_result {
#define LSAMP__ENUM(name, text) name,
    LSAMP_RESULTS(LSAMP__ENUM)
#undef LSAMP__ENUM
    LSAMP_RESULT_COUNT
} lsamp_result;

typedef struct lsamp_light lsamp_light; /* a light, ready to be sampled, in memory that you own */
struct lsamp_light_desc;            /* its shape and what it emits */
struct lsamp_points;                /* the points to be lit, with their materials */
struct lsamp_sample_desc;           /* how many samples, drawn how */
struct lsamp_samples;               /* arrays that receive the samples */

LSAMP_DEF size_t lsamp_light_bytes(const struct lsamp_light_desc *desc);
/* Returns the bytes that lsamp_light_init needs for this desc: at most 512, and 22 for each texel, 26 for
   each row and 4 for each column of texels; for a mesh 64 for each triangle and 272 for each place. Returns 0
   if the desc is refused; lsamp_light_init tells the log why. */

LSAMP_DEF lsamp_result lsamp_light_init(const struct lsamp_light_desc *desc, void *memory,
                                        size_t memory_bytes, lsamp_light **out, uint64_t *bad_texels);
/* Makes a light in your memory. There is nothing to free: the light ends when you take the memory back. To
   move or change a light, make it again, for each frame if need be.
   memory      lsamp_light_bytes(desc) bytes or more, aligned to 8 bytes
   out         receives the light, which lies in memory, on LSAMP_OK only
   bad_texels  may be NULL; receives the number of texels with a channel that is negative or not finite, in
               the frames that desc.time blends; such a channel counts as 0
   Errors      LSAMP_ERR_ARGUMENT (NULL; of the mesh a pointer, a count, a stride), LSAMP_ERR_DESC,
               LSAMP_ERR_INPUT (an index of the mesh, a mesh without area), LSAMP_ERR_LIMIT (a mesh of 2^31
               vertices, memory beyond size_t), LSAMP_ERR_MEMORY (too small, not aligned)
   Cost        time grows with the texels of one frame, or with the triangles and places of a mesh */

LSAMP_DEF lsamp_result lsamp_sample(const struct lsamp_sample_desc *desc, const lsamp_light *light,
                                    const struct lsamp_points *points, const struct lsamp_samples *out,
                                    size_t *useful);
/* Draws directions from each point towards the light, and weighs each of them with material and light. A
   point's samples depend on its own inputs and pixel only, so that a batch of points may be cut anywhere.
   points  A point whose position is not finite, or one of whose vectors is 0 0 0 or not finite, is no
           receiver: its samples have weights of 0
   out     receives points->count x desc->sample_count samples
   useful  may be NULL; receives the number of samples whose weight is not 0: only these need visibility
   Errors  LSAMP_ERR_ARGUMENT (NULL, a stride), LSAMP_ERR_DESC, LSAMP_ERR_INPUT (a vector whose length
           is not 0.97 to 1.03, a material out of range), LSAMP_ERR_LIMIT (size_t cannot count the samples)
   Cost    time grows with points x samples */

LSAMP_DEF lsamp_result lsamp_accumulate(size_t count, uint32_t sample_count, const float *weights,
                                        const float *visible, float *radiance, size_t radiance_stride);
/* Adds weight x visibility of each point's samples to its radiance.
   count       of points; sample_count is the number of samples of each
   weights     those of lsamp_sample
   visible     one float for each sample, 0..1; NULL: all samples are lit. Values below 0, such as
               COHSM_REFUSED of csm.h, count as 0
   radiance    3 floats for each point, W/(sr m^2), radiance_stride bytes apart (a multiple of 4, >= 12;
               0 = 12); set them to 0 before the first light
   Errors      LSAMP_ERR_ARGUMENT (NULL, a sample_count of 0, a stride). There is no log */

LSAMP_DEF const char *lsamp_result_text(lsamp_result result);
/* Returns a constant string that says what a result means; "unknown result" for a number that is none. */

/* ---- the caller's services: of these only log is called here, since nothing allocates ---- */

typedef struct lsamp_allocator {    /* all zero: malloc and free; else both functions */
    void *(*alloc_fn)(size_t bytes, void *user);    /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} lsamp_allocator;

typedef void (*lsamp_task)(void *context, size_t index);

typedef struct lsamp_system {       /* all zero: malloc and free, this thread alone, no progress, no log */
    lsamp_allocator allocator;      /* called from the thread that called us */
    void (*parallel_for)(void *user, size_t count, lsamp_task task, void *context);
    /* Must call task(context, i) once for each i < count, in any order and on any threads, and return when
       all are done. What is computed does not depend on the threads. */
    int (*progress)(void *user, float fraction);
    /* Called from the thread that called us, fraction 0..1 never falling within a call; not 0 cancels. */
    void (*log)(void *user, const char *message);
    /* Called at most once by a call that fails, from the thread that called us, before it returns: one line
       without a line end that names the function, the field or element, its value and its range. */
    void *user;                     /* given to parallel_for, progress and log */
} lsamp_system;

/* ---- structs of page one ---- */

typedef struct lsamp_mesh {
    const float    *positions;      /* x, y, z of each vertex */
    size_t          vertex_count;
    size_t          vertex_stride;  /* bytes from one vertex to the next, a multiple of 4, >= 12; 0 = 12 */
    const uint32_t *indices;        /* three to a triangle; NULL = indices16, or else 0, 1, 2, ... */
    size_t          index_count;    /* a multiple of 3 (ignored without indices: vertex_count is used) */
    const uint16_t *indices16;      /* in place of indices; not both */
} lsamp_mesh;

typedef enum lsamp_light_kind {     /* the shape that emits, and its coordinates x, y in [0, 1)^d, of which
                                       equal ranges cover equal areas (of a sky: all directions) */
    LSAMP_LIGHT_DEFAULT,            /* = LSAMP_LIGHT_ENVIRONMENT */
    LSAMP_LIGHT_ENVIRONMENT,        /* the sky: x = 0.5 + atan2(z, x) / (2 pi), y = acos(y) / pi of a
                                       direction, so that row 0 is +Y and the centre +X */
    LSAMP_LIGHT_SUN,                /* one direction; no coordinates */
    LSAMP_LIGHT_POINT,              /* one position; no coordinates */
    LSAMP_LIGHT_SPOT,               /* a round cone with a hard edge; no coordinates */
    LSAMP_LIGHT_LINE,               /* a cylinder without caps; x runs along it */
    LSAMP_LIGHT_RECTANGLE,          /* position + x u + y v; emits along u x v */
    LSAMP_LIGHT_DISC,               /* a disc that emits along direction; x, y go to it by Shirley and Chiu's
                                       concentric map of the square */
    LSAMP_LIGHT_SPHERE,             /* x as in the environment, y = (1 - cos of the angle from +Y) / 2; emits
                                       outwards */
    LSAMP_LIGHT_CALLBACK,           /* points of your own, by shape_fn */
    LSAMP_LIGHT_MESH,               /* triangles that emit to the side from which their corners run
                                       counter-clockwise. x runs along a curve through all of them, in
                                       proportion to area; y and z lie in the piece that x names */
    LSAMP_LIGHT_SURFACE,            /* a grid of points, between which the surface is bilinear: x runs along
                                       its rows and y across them. Equal ranges cover equal areas only where
                                       the grid's cells do */
    LSAMP_LIGHT_COUNT
} lsamp_light_kind;

typedef enum lsamp_texels {         /* what L is between the centres of texels */
    LSAMP_TEXELS_DEFAULT,           /* = LSAMP_TEXELS_NEAREST */
    LSAMP_TEXELS_NEAREST = LSAMP_TEXELS_DEFAULT,    /* that of the nearest texel */
    LSAMP_TEXELS_LINEAR,            /* linear along both coordinates, as in section 5: a glossy surface shows
                                       a continuous highlight in place of squares (figure 12). Columns of a
                                       sky, a sphere and a round surface go round; at other edges the last
                                       texel goes on */
    LSAMP_TEXELS_COUNT
} lsamp_texels;

typedef struct lsamp_surface {      /* A of LSAMP_LIGHT_SURFACE as a table */
    uint32_t     width, height;     /* 2..4096 each */
    const float *points;            /* x, y, z of each, height rows of width. The surface emits to the side of
                                       the cross product (along the rows) x (across them). Where points are
                                       not finite, or cells have no area, it does not emit */
    int          round;             /* not 0: after the last column comes the first, with cells between */
} lsamp_surface;

typedef void (*lsamp_shape_fn)(void *user, float time, const float x[3], float position[3], float normal[3],
                               float *area);
/* Writes the point of the surface at x in [0, 1)^3, the normal of the side that emits (0, 0, 0: a volume,
   which emits without a cosine), and the Jacobian d area / dx there, whose mean over all x is the area (or
   volume). */

typedef void (*lsamp_emission_fn)(void *user, float time, const float x[3], const float direction[3],
                                  float rgb[3]);
/* Writes a factor of the radiance that leaves the point x along the unit direction. For environments the
   direction points from the surface to the sky. Values that are negative or not finite count as 0. */

typedef struct lsamp_light_desc {   /* zero it, then set what this kind of light has */
    lsamp_system      system;       /* its log says why a desc is refused */
    lsamp_light_kind  kind;
    float             position[3];  /* centre of a point, spot, disc or sphere; corner of a rectangle; start
                                       of a line; -1e18..1e18, like u and v */
    float             direction[3]; /* unit; sun: towards it; spot: out of the lamp; disc: its normal */
    float             u[3], v[3];   /* edges of a rectangle; u of a line: end - start */
    float             radius;       /* of a disc, sphere or line, 1e-18..1e18. Of a mesh: the distance from
                                       its surface, on the side that emits, at which lsamp_light_domain puts
                                       the places for maps, 0..1e18 */
    float             cone_half_angle; /* of a spot: from its axis to its edge, 5e-7..pi / 2 */
    float             radiance[3];  /* 0..1e30. Radiance L, W/(sr m^2); point and spot: intensity, W/sr; sun:
                                       irradiance of a surface that faces it, W/m^2 */
    float             cosine_power; /* of shapes that have an area: L(theta) = radiance cos^power(theta),
                                       0..1e5; 0 is a Lambertian emitter */
    float             rotation;     /* of an environment: radians about +Y, -1000..1000 */
    const float      *texels;       /* factors of radiance over the coordinates: frames one after another,
                                       each height rows of width rgb texels. `filter` says what is between
                                       their centres. lsamp_light_init copies the frames that it blends. Set
                                       radiance too: it is 1 1 1 for texels that are radiance, and 0 makes all
                                       black. NULL = 1 everywhere. Not for sun, point, spot and mesh */
    uint32_t          width, height;     /* 1..65536 with texels (height 1 for a line), 0 without */
    uint32_t          frame_count;       /* of texels, 1..2^24; 0 = 1 */
    float             frames_per_second; /* 0..1e6; 0 = 30. Frames are blended linearly */
    int               loop;              /* not 0: the frame after the last is the first; 0: the last stays */
    float             time;              /* seconds, -1e9..1e9: the moment that the light shows */
    lsamp_shape_fn    shape_fn;          /* of LSAMP_LIGHT_CALLBACK */
    lsamp_emission_fn emission_fn;       /* NULL = 1 everywhere; not for sun, point and spot */
    void             *user;              /* given to shape_fn and emission_fn */
    const lsamp_mesh *mesh;              /* of LSAMP_LIGHT_MESH, in world space; lsamp_light_init copies it.
                                            Triangles that are not finite or have no area do not emit */
    uint32_t          place_count;       /* how many places for maps lsamp_light_domain gives for a mesh,
                                            1..2^24; 0 = 1024. The mesh is cut into twice as many pieces, or
                                            more */
    lsamp_texels      filter;            /* of texels; without texels it changes nothing */
    const lsamp_surface *surface;        /* of LSAMP_LIGHT_SURFACE, in world space; it and its points are read
                                            whenever the light is sampled, and must live as long */
} lsamp_light_desc;

typedef enum lsamp_material_kind {
    LSAMP_MATERIAL_DEFAULT,         /* = LSAMP_MATERIAL_LAMBERT */
    LSAMP_MATERIAL_LAMBERT,         /* diffuse / pi */
    LSAMP_MATERIAL_PHONG,           /* Lambert + specular (n + 2) / (2 pi) cos^n(angle between w and the
                                       mirrored to_eye) */
    LSAMP_MATERIAL_LAFORTUNE,       /* Lambert + the sum over lobes of scale max(0, w . C to_eye)^n (Lafortune
                                       et al. 1997) */
    LSAMP_MATERIAL_METAL_ROUGH,     /* as in glTF: diffuse (1 - metallic) (1 - F) / pi + GGX, with F0 from
                                       0.04 to diffuse by metallic */
    LSAMP_MATERIAL_COUNT
} lsamp_material_kind;

#define LSAMP_MAX_LOBES 8u

typedef struct lsamp_lobe {         /* of Lafortune's model; axes are tangent, bitangent, normal */
    float axis[3];                  /* Cx, Cy, Cz, -10..10: -1, -1, 1 mirrors; Cx != Cy needs a tangent */
    float exponent;                 /* 0..1e5 */
    float scale[3];                 /* r, g, b, 0..1e9, 1/sr */
} lsamp_lobe;

typedef struct lsamp_material {
    lsamp_material_kind kind;
    float             diffuse[3];   /* albedo 0..1 (no energy is made if diffuse + specular <= 1);
                                       METAL_ROUGH: the base colour */
    float             specular[3];  /* PHONG: albedo 0..1 of the lobe for an eye along the normal, where it is
                                       largest */
    float             exponent;     /* PHONG: n, 0..1e5 */
    float             metallic;     /* METAL_ROUGH: 0..1 */
    float             roughness;    /* METAL_ROUGH: 0..1; alpha = roughness^2, not below 0.002 */
    const lsamp_lobe *lobes;        /* LAFORTUNE */
    uint32_t          lobe_count;   /* LAFORTUNE: 0..LSAMP_MAX_LOBES */
} lsamp_material;

typedef struct lsamp_points {       /* receivers; strides are bytes, multiples of 4, >= 12, and 0 = 12 */
    size_t                count;
    const float          *positions;        /* x, y, z of each, world space */
    size_t                position_stride;
    const float          *normals;          /* unit shading normals; 0 0 0, or not finite: no receiver, its
                                               weights are 0 */
    size_t                normal_stride;
    const float          *to_eye;           /* unit directions to the eye; NULL = normals */
    size_t                to_eye_stride;
    const float          *tangents;         /* unit; NULL = any */
    size_t                tangent_stride;
    const lsamp_material *materials;        /* one for each, or one for all */
    size_t                material_stride;  /* 0: one material for all; else sizeof(lsamp_material) or above,
                                               a multiple of sizeof(void *) */
    const uint32_t       *pixels;           /* the pixel y * width + x of each point, by which its random
                                               numbers are chosen; NULL = 0, 1, ... */
} lsamp_points;

typedef enum lsamp_sampling {       /* from which density directions are drawn. Sun, point, spot, callback,
                                       mesh and surface always use the density of the light */
    LSAMP_SAMPLING_DEFAULT,         /* some samples from the light's density and some from the material's,
                                       weighted by the balance heuristic (Veach and Guibas 1995); the solid
                                       angle of the light and the width of the lobe decide how many of each */
    LSAMP_SAMPLING_LIGHT,           /* the light's density, P_L */
    LSAMP_SAMPLING_BRDF,            /* the material's density, P_f */
    LSAMP_SAMPLING_PAPER,           /* as in section 5.1: of an environment the diffuse part by P_L and the
                                       specular part by P_f, with roulette between them by k_d, the diffuse
                                       share of the albedo; every other light by P_L */
    LSAMP_SAMPLING_COUNT
} lsamp_sampling;

typedef struct lsamp_sample_desc {
    lsamp_system   system;          /* its log says what was refused */
    uint32_t       sample_count;    /* S, the samples of each point, 1..65536 */
    lsamp_sampling sampling;
    uint32_t       seed;            /* another seed makes other noise: give each light a seed of its own */
    uint32_t       frame;           /* the number of the frame in progressive rendering: frame i takes the
                                       random numbers that follow those of frame i - 1 */
    const float   *patterns;        /* from lsamp_patterns_build with length S; NULL = each pixel has a
                                       scrambled (0, 2)-sequence, which converges faster over many frames */
} lsamp_sample_desc;

typedef struct lsamp_samples {      /* room for count * S each; sample k of point i is number i S + k */
    float *directions;              /* 3 floats, unit; the normal where the weight is 0 and no direction was
                                       found; 0 0 0 for a point that is no receiver */
    float *distances;               /* how far the light is; LSAMP_INFINITY for sky and sun. The point on the
                                       light is position + distance direction */
    float *coords;                  /* 3 floats, the light's coordinates of that point; NULL = not wanted */
    float *weights;                 /* 3 floats: f L cos / (pdf S) */
} lsamp_samples;

#define LSAMP_INFINITY 340282346638528859811704183484516925440.0f   /* the largest float */
