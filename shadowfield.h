/* shadowfield.h - v1.0.0 - shadow fields: soft shadows of moving objects and lights - MIT-0 OR Unlicense

   What it does

   This header gives moving objects soft shadows from moving lights. For each object it records once, at
   sample points on spheres round the object, which directions the object hides (an occlusion field); for each
   light, what arrives from the light there (a source field). At run time any number of instances of the
   fields move, turn and scale evenly. The light that reaches a point is a product of a few field samples,
   with the shadows of local lights, video lights and the environment together. After Zhou, Hu, Lin, Guo and
   Shum, "Precomputed Shadow Fields for Dynamic Scenes", SIGGRAPH 2005. Fields are kept in one of two bases:
   real spherical harmonics (fast, soft) or Haar wavelets (all frequencies, slow).

   What it does not do

   - Objects are rigid. Light bounces from body to body, once a frame, if you ask for it. Points are shaded:
     your vertices, probes or pixels.
   - Four bands of harmonics blur everything finer than about 45 degrees; small lights need wavelets.
   - The header renders no pictures, opens no files and starts no threads.

   Quick start

   In exactly one source file write the define; everywhere else include the header alone.

       #define SHADOWFIELD_IMPLEMENTATION
       #include "shadowfield.h"
       #include <stdio.h>
       #include <string.h>

       int main(void)
       {
           static const float corners[] = { -1, 0, -1,  1, 0, -1,  1, 0, 1,  -1, 0, 1 };    // a square
           static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2 };
           const float place[6] = { 0, -0.5f, 0,  6, -0.5f, 0 }, up[6] = { 0, 1, 0,  0, 1, 0 };
           const float sky[3] = { 1, 1, 1 };
           float rgb[6] = { 0, 0, 0, 0, 0, 0 };
           sfield_mesh mesh = { corners, 4, 0, triangles, 6, NULL, NULL, NULL };
           sfield_entity square;
           sfield_points points;
           sfield_field *field;
           sfield_scene *scene;

           if (sfield_build(NULL, &mesh, &field, NULL) != SFIELD_OK) return 1;     // 384 KB, within a second
           if (sfield_scene_create(NULL, &scene) != SFIELD_OK) return 1;
           memset(&square, 0, sizeof square);
           square.occlusion = field;                               // square.transform: where it is now
           sfield_scene_entities(scene, &square, 1);
           sfield_scene_environment(scene, sky, 1, 1, NULL);       // radiance 1 from everywhere
           memset(&points, 0, sizeof points);
           points.count = 2;
           points.positions = place;
           points.normals = up;
           points.rgb = rgb;
           sfield_shade(scene, &points, 1, NULL);
           printf("irradiance / pi: %g below the square, %g beside it\n", (double)rgb[0], (double)rgb[3]);
           sfield_scene_free(scene);
           sfield_free(field);
           return !(rgb[0] < 0.7f && rgb[3] > 0.9f);
       }

   Conventions

   Space is right-handed. Matrices are column-major float[16]; a matrix of zeros is the identity. Directions
   point from the surface to the light and are unit: a length of 0.97..1.03 is used as it is, and any other
   but 0 is an error. Distances are in your units, angles in radians, radiance in W/(sr m^2), irradiance in
   W/m^2. All zero is the default of every desc.

     r          the radius of an entity's bounding sphere, whose centre is the centre of the field
     entity     an instance of an occlusion field, of a source field or of both, with its own transform
     shell      one of the concentric spheres; its sample points lie on the grid of a cube, 6 x side x side
     cube       what is seen from a sample point: 6 x N x N texels, faces +X -X +Y -Y +Z -Z as OpenGL orders
                them
     texel      number face N^2 + morton(x, y) of a cube: sfield_cube_texel gives its direction and solid
                angle
     occlusion  alpha: 1 hidden, 0 free. Queries return visibility, 1 - alpha
     bands      n bands of spherical harmonics are n^2 coefficients; coefficient l^2 + l + m belongs to band
                l, and those of band 1 belong to 0.4886 y, 0.4886 z and 0.4886 x
     planes     many vectors of coefficients lie in planes: coefficient k of vector i is v[k * stride + i], so
                that 16 vectors are treated at a time. With stride 1 a single vector is a plain array
     T          of a point and a light: BRDF x cosine x visibility, what of the light counts for the point

   How it works

     once        sfield_build (objects), sfield_build_emitter or _emissive (lights), or sfield_open (files)
     once        sfield_scene_create, sfield_scene_environment
     each frame  sfield_scene_entities, sfield_shade

   A query at distance d finds the two shells around d and interpolates eight samples. The radii of shells
   grow by a factor; weights are linear in the solid angle of the bounding sphere (occlusion) or in (r/d)^2
   (sources). Beyond the last shell both fall as (r/d)^2, as small things do that are seen from afar. To shade
   a point, T starts as BRDF x cosine x self-visibility and is multiplied by the visibility of each entity,
   from near to far. A light adds its dot product with the T that stands when the light is reached; the
   environment is the farthest light.

     harmonics  have coefficients of 8 bits, scaled for each shell, band and order: shells x 6 side^2 x n^2
                bytes (three times as many for lights). With all defaults a box takes 0.6 s and 0.4 MB, a lamp
                3 s and 1.2 MB
     wavelets   are orthonormal on the planar face of a cube; the largest are kept, with 4 bytes each (8 for
                lights). With all defaults a box takes 15 s and 33 MB, a lamp 50 s and 62 MB

   The knobs, and what each trades:

     bands            fewer: faster and softer, and light leaks round objects. Time grows with bands^4
     position_side    fewer: shadows wobble as things move past sample points
     keep             less: noise of 2 x 2 texels in shadows, since fewer wavelets are kept
     cube_side        less: penumbrae in steps, since texels are larger
     keep_inside      0: positions inside a closed mesh see from its surface. Not 0: nothing, which darkens

   From the paper to the code

     section 3.1  an object occlusion field, shell by shell      sfield_build, sfield_build_callback  T72
     section 3.1  a source radiance field                        sfield_build_emitter                 T73
     section 3.1  S_d, the environment, and its rotation         sfield_scene_environment,
                                                                 sfield_scene_turn                    T11 T12
     section 3.1  O_p, what an object hides from its own points  sfield_build_self                    -
     section 3.1  sampling densities by a level of error         sfield_place                         -
     section 3.2  incident radiance, from far to near            sfield_incident                      T78
     section 3.2  spheres of lights and objects do not overlap   sfield_scene_desc (strict)           T80
     section 3.3  concentric shells from 0.2 r to 8 r or 20 r    sfield_desc (inner, outer)           T74
     section 3.3  eight samples of concentric shells             sfield_query                         T74 T75
     section 3.3  16 coefficients of 8 bits                      sfield_sh_project, sfield_build      T77
     section 3.3  area-weighted choice of wavelets               sfield_build                         T81
     section 4    B, the rendering equation                      sfield_shade                         T73
     section 4    the BRDF at the beginning, before occluders    sfield_points (materials, exponents) -
     section 4.1  G_i = sum of C_ijk E_j F_k: triple products    sfield_sh_product, sfield_sh_terms   T5 T6
     section 4.1  the same of wavelets, in sublinear time        sfield_haar_product                  T81
     section 4.1  the double product                             sfield_sh_dot                        T2
     section 4.1  rotations                                      sfield_sh_rotation                   T9 T76
     figure 5     entities from near to far                      sfield_scene_entities, sfield_shade  T78
     section 4.2  points that the viewer does not see            sfield_points (in_view)              -
     section 4.2  culling, with a count for each of its rules    sfield_scene_stats                   -
     section 4.2  lazy occlusion updating                        sfield_cache_create                  T79
     section 5    lights that are videos, by key frames          sfield_desc (frame_count),
                                                                 sfield_entity                        -
     section 6    few vertices shaded, the others interpolated   sfield_sparse, sfield_spread         -
     section 6    radiance from interreflections                 sfield_bounce_create                 -

   T.. are rows of docs/conformance.md. Where there is a -, tests/shadowfield/ has tests without a row.

   Configuration

     SHADOWFIELD_IMPLEMENTATION   in one source file: compiles the code
     SFIELD_STATIC                with the implementation: a private copy, all functions static
     SFIELD_DEF                   everywhere: your own linkage instead
     SFIELD_NO_SIMD               with the implementation: no intrinsics (results equal but for rounding)
     SFIELD_FILE                  with the implementation: this file's name, if it is not "shadowfield.h". The
                                  file includes itself for AVX2 and AVX-512; where it cannot, it does without
                                  them

   In the repository, make join shadowfield.h WITHOUT="build" writes this header without the precomputation,
   for programs that only open files and shade; WITHOUT="all" leaves out all optional parts, wavelets and
   intrinsics among them (src/README.md).

   Memory, errors, threads, determinism

   All memory comes from the system's allocator, called from the thread that called us. Every function that
   can fail returns a sfield_result. If the result is not SFIELD_OK, outputs are untouched and nothing leaks,
   and the system's log is told which argument, field or element has which value, and what it must be; that
   memory ran out the result may tell alone. Fields, algebras and scenes keep allocator, log and user of the
   system that they were made with: these must live as long. A call without such an object has no log.
   There are no globals: any number of threads may read fields and algebras at once. A scene belongs to one
   call at a time, which spreads its work by your parallel_for. Built fields have the same bytes on every
   compiler, processor, byte order and thread count (not with x87 arithmetic, nor with clang's -ffast-math).
   Shading does not depend on the number of threads.

   Cost: docs/measured/shadowfield.md and build/bench sfield_algebra, sfield_chess, sfield_wavelet.
   History: CHANGELOG.md.   Licence: end of this file. */
#ifndef SHADOWFIELD_H
#define SHADOWFIELD_H

#define SFIELD_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "shadowfield.h needs C99 or C++11: -std=c99"
#endif
#if defined(SFIELD_STATIC) && !defined(SHADOWFIELD_IMPLEMENTATION)
#error "SFIELD_STATIC makes private functions: define SHADOWFIELD_IMPLEMENTATION beside it"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef SFIELD_DEF
#ifdef SFIELD_STATIC
#define SFIELD_DEF static inline
#else
#define SFIELD_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/shadowfield/api.h ==== */

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

/* ==== src/shadowfield/api_fields.h ==== */

/* ---- fields ---- */

typedef enum sfield_basis {         /* the functions by which a field keeps what is seen from a point */
    SFIELD_BASIS_DEFAULT,           /* = SFIELD_BASIS_SH */
    SFIELD_BASIS_SH,                /* spherical harmonics: soft and fast */
    SFIELD_BASIS_HAAR,              /* Haar wavelets: all frequencies, slow. A header joined without them
                                       refuses it */
    SFIELD_BASIS_COUNT
} sfield_basis;

typedef enum sfield_spacing {       /* how far apart the shells are */
    SFIELD_SPACING_DEFAULT,         /* = SFIELD_SPACING_GEOMETRIC */
    SFIELD_SPACING_GEOMETRIC,       /* radii grow by a factor, and weights are linear in solid angle: between
                                       shells a sphere hides what it should within 2 % */
    SFIELD_SPACING_UNIFORM,         /* as in the paper: radii grow by a step, and weights are linear in the
                                       distance: 15 % wrong at 1.5 r */
    SFIELD_SPACING_COUNT
} sfield_spacing;

#ifndef SFIELD_WITHOUT_BUILD
typedef struct sfield_desc {        /* zero it, then set what you care about */
    sfield_system  system;
    sfield_basis   basis;
    uint32_t       bands;           /* of harmonics, 1..8; 0 = 4 */
    uint32_t       cube_side;       /* texels a side of a cube's face, a power of two, 4..64; 0 = 16 (wavelets
                                       32) */
    uint32_t       shell_count;     /* 2..64; 0 = 16 (wavelets 32) */
    uint32_t       position_side;   /* sample points a side of a face of a shell, 2..64; 0 = 16 (wavelets
                                       32) */
    sfield_spacing spacing;
    float          inner;           /* radius of the first shell, in radii of the bounding sphere,
                                       0.001..1000; 0 = 0.2 */
    float          outer;           /* radius of the last shell, in the same unit, 1.1 inner..1000; 0 = 8
                                       (wavelets 20). Neighbouring shells must be 0.02 % apart at least */
    const float   *radii;           /* shell_count radii in place of those from inner to outer, which are not
                                       used then, in the same unit: 0.001..1000, each 0.02 % above the one
                                       before at least. sfield_place chooses such. NULL = as spacing says */
    float          keep;            /* of wavelets: the share of a cube's coefficients that is kept at most,
                                       0..1; 0 = 0.01 */
    float          window;          /* of harmonics: the strength of sfield_sh_window for every cube, 0..1e6;
                                       0 = no window */
    int            logarithm;       /* of occlusion in harmonics: not 0 stores the logarithm of visibility,
                                       which SFIELD_PRODUCT_EXP needs */
    uint32_t       frame_count;     /* of sources: steps of time, 1..256; 0 = 1 */
    float          frames_per_second; /* of sources, 1e-6..1e6; 0 = 30 */
    int            loop;            /* not 0: after the last frame comes the first; 0: the last stays */
    float          center[3];       /* of the bounding sphere, -1e18..1e18 */
    float          radius;          /* of the bounding sphere, which must hold the mesh or emitter,
                                       1e-18..1e18. 0 = fitted: to a mesh, center too; to an emitter about
                                       center, where the emitter stands. Callbacks need a radius */
    uint32_t       shard_begin;     /* to build in parts, each by another process: the first shell of this
                                       part, counted through all frames */
    uint32_t       shard_end;       /* the shell after the last one of this part; 0 = all shells, the whole
                                       field, as self-visibility needs. sfield_merge joins the parts */
    int            keep_inside;     /* not 0: sample points inside a closed mesh see nothing, as in the paper;
                                       0: they take the view from just outside the surface */
} sfield_desc;

typedef struct sfield_stats {       /* what a build counted */
    uint32_t triangles;             /* triangles that were used */
    uint32_t skipped_triangles;     /* triangles with a vertex that is not finite, or with two equal
                                       corners */
    uint64_t coefficients;          /* wavelets that were kept */
    double   lost;                  /* relative L2 error, over all samples, of the wavelets that were not
                                       kept */
    size_t   peak_bytes;            /* the most memory that was asked of the allocator at once */
    uint64_t moved;                 /* sample points inside the mesh whose view was taken outside */
} sfield_stats;

SFIELD_DEF sfield_result sfield_build_emissive(const sfield_desc *desc, const sfield_mesh *mesh,
                                               const float *radiance, sfield_field **out,
                                               sfield_stats *stats);
/* Builds the source field of an emissive mesh.
   radiance  r, g, b of each triangle, 0..1e18 W/(sr m^2); with several frames one such array after the other.
             A triangle shines on the side from which its corners are counter-clockwise; for both sides give
             the triangle once more, turned over. A triangle of radiance 0 hides those behind it
   Errors    as sfield_build; SFIELD_ERR_INPUT also for a radiance out of its range */

typedef void (*sfield_view_fn)(void *user, float time, const float position[3], const float direction[3],
                               float rgb[3]);
/* A function of yours that writes what arrives at a position from a direction: for sources the radiance, for
   occlusion alpha in rgb[0], 1 = hidden. parallel_for's threads call the function. Values that are negative
   or not finite count as 0, those above 1e18 as 1e18.
   time       seconds from the first frame
   position   in the field's space
   direction  unit, pointing away from the position */

typedef enum sfield_emitter_kind {  /* the shape of an analytic light */
    SFIELD_EMITTER_DEFAULT,         /* = SFIELD_EMITTER_SPHERE */
    SFIELD_EMITTER_SPHERE,          /* a sphere of `radius` about the centre */
    SFIELD_EMITTER_DISC,            /* a disc of `radius` about the centre, which shines along `normal` */
    SFIELD_EMITTER_RECTANGLE,       /* a rectangle about the centre with the half axes u and v, which shines
                                       along u x v */
    SFIELD_EMITTER_LINE,            /* a line about the centre, from -u to u, of no width. Its radiance is in
                                       W/(sr m): that of a thin tube times the diameter of the tube */
    SFIELD_EMITTER_CYLINDER,        /* a lamp tube: the side of a cylinder of `radius` about the centre, from
                                       -u to u. Whoever looks into an open end sees the dark; points within
                                       the tube see light all round, as those within a sphere do */
    SFIELD_EMITTER_CALLBACK,        /* whatever view_fn says. Directions that miss the bounding sphere are not
                                       asked */
    SFIELD_EMITTER_COUNT
} sfield_emitter_kind;

typedef struct sfield_emitter {     /* an analytic light in the field's space, about desc.center */
    sfield_emitter_kind kind;
    float radius;                   /* of a sphere, disc or cylinder, 1e-17..1e17 */
    float normal[3];                /* of a disc, unit; the others but rectangles may have one, or 0 0 0 */
    float u[3], v[3];               /* of a rectangle, any length; half a diagonal is 1e-17..1e17. u alone of
                                       a line or cylinder, whose bounding sphere has a radius in that range */
    float radiance[3];              /* r, g, b, 0..1e18 W/(sr m^2); of a line, W/(sr m) */
    float cone_half_angle;          /* the light leaves within this angle about the normal, 0..pi; 0 = pi / 2.
                                       What may have a normal and has none shines everywhere */
    sfield_view_fn view_fn;         /* of SFIELD_EMITTER_CALLBACK */
    void *user;                     /* given to view_fn */
} sfield_emitter;

SFIELD_DEF sfield_result sfield_build_emitter(const sfield_desc *desc, const sfield_emitter *emitter,
                                              sfield_field **out, sfield_stats *stats);
/* Builds the source field of an analytic light or of a callback. desc and stats may be NULL, but a callback
   needs desc.radius.
   Errors  SFIELD_ERR_DESC (a field of desc or emitter), SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_ALLOC,
           SFIELD_ERR_LIMIT, SFIELD_ERR_CANCELLED */

SFIELD_DEF sfield_result sfield_build_callback(const sfield_desc *desc, sfield_view_fn alpha_fn, void *user,
                                               sfield_field **out, sfield_stats *stats);
/* Builds an occlusion field by asking a function of yours, such as a ray tracer's, whether each direction
   from each sample point is hidden. desc is needed, since desc.radius must be set.
   alpha_fn  called with user for several directions in each texel; what it writes above 1 counts as 1
   Errors    as sfield_build_emitter */

typedef struct sfield_views {       /* sample points, 1..256 at a time, from which your renderer is to look */
    float        center[3], radius; /* bounding sphere of the field */
    float        time;              /* seconds from the first frame of a source */
    size_t       count;             /* eyes */
    const float *eyes;              /* (position - center) / radius, three floats each. Eyes lie on the shell,
                                       or just outside the mesh */
    float       *values;            /* to be written, for one eye after the other: alpha, where 1 is hidden;
                                       of sources r, then g, then b. Harmonics: bands^2 coefficients, as
                                       sfield_sh_project makes them from texels. Wavelets: 6 N^2 texels */
} sfield_views;

typedef int (*sfield_views_fn)(void *user, const sfield_views *views);
/* A function of yours that fills views->values. The thread that called sfield_build_views calls the function,
   shell after shell. Returns 0 to go on; anything else ends the build. */

SFIELD_DEF sfield_result sfield_build_views(const sfield_desc *desc, int source, const sfield_mesh *mesh,
                                            sfield_views_fn see_fn, void *user, sfield_field **out,
                                            sfield_stats *stats);
/* Builds a field whose cubes another renderer draws and projects, such as gl_shadowfield.h.
   sfield_build_views itself applies windows and logarithms, chooses wavelets and compresses.
   source   not 0: the field is a source's, and values are radiances; 0: it is of occlusion
   mesh     the mesh that you draw. The bounding sphere and the inscribed one are taken from it, and sample
            points inside it are asked again from outside (desc.keep_inside). NULL: desc.radius must be set,
            no sphere is inscribed, and no sample point is moved
   see_fn   called with user. Values that are not finite, or beyond 1e18 (of occlusion 100), count as 0
   Errors   as sfield_build; SFIELD_ERR_CANCELLED also if see_fn returned not 0 */

SFIELD_DEF sfield_result sfield_build_self(const sfield_desc *desc, const sfield_mesh *mesh,
                                           const sfield_points *points, float offset, sfield_field **out,
                                           sfield_stats *stats);
/* Builds the self-visibility of points on a mesh (O_p in the paper), for sfield_points.self: what each point
   sees from its position + offset x its normal. Harmonics store visibility x max(0, cosine), wavelets the
   occlusion. A point inside another part of the mesh looks from outside too (desc.keep_inside).
   points   count (1..2^31 - 1), positions (-1e18..1e18) and normals with their strides; the other members are
            not read
   offset   0..1e18, in units of the mesh; a thousandth of its size keeps a point from seeing its own triangle
   Errors   as sfield_build; SFIELD_ERR_ARGUMENT also for a stride, no points or the offset; SFIELD_ERR_INPUT
            also for positions out of range and normals that are not unit */

typedef struct sfield_placement {   /* where the sample points of a field are to lie */
    uint32_t shell_count;           /* for desc.shell_count */
    float    radii[64];             /* for desc.radii, shell_count of them */
    uint32_t position_side;         /* for desc.position_side */
    float    between;               /* the greatest error that was measured between shells ... */
    float    across;                /* ... and between the points of a shell */
} sfield_placement;

SFIELD_DEF sfield_result sfield_place(const sfield_desc *desc, const sfield_mesh *mesh,
                                      const sfield_emitter *emitter, float bound, sfield_placement *out);
/* Chooses the sample points of a field by the error of interpolation that it measures: what queries would
   interpolate beside what is seen, from 26 directions at 129 distances, and in 24 squares of each shell. Give
   the same desc with these values to sfield_build or sfield_build_emitter. Errors leave out what 8 bits or
   `keep` lose. With wavelets they are those of means over 8 x 8 squares a face.
   desc     as for the build, NULL = all defaults. Shells lie from inner to outer, or from the first to the
            last of desc.radii. shell_count is the most that may be used (0: 64 with a bound), and a
            position_side that is not 0 is kept. Points inside a mesh take their view from its surface, which
            jumps from point to point: with a bound set inner to 1 or more
   mesh     of an occlusion field, or NULL; one of mesh and emitter is given
   emitter  of a source field, or NULL. A function is asked at time 0 only
   bound    0..1, of the sum of both errors, half of it for each. They are RMS over all directions, at the
            worst distance: of visibility (or its logarithm, if that is stored), or of a source's radiance
            divided by the RMS of that. 0 = no bound: desc.shell_count shells (0: as for a build) are placed
            so that they err least
   out      written on SFIELD_OK only
   Errors   as sfield_build; SFIELD_ERR_ARGUMENT also for the bound and if mesh and emitter are both given or
            both NULL, SFIELD_ERR_LIMIT also if the bound needs more shells or points than there may be
   Cost     3,354 views, and 120 for each shell and each position_side that is tried; then, without a bound,
            up to 180,000 comparisons of 26 views, on one thread. Memory: as a build, and 0.3 MB (harmonics of
            4 bands) to 16 MB */

SFIELD_DEF sfield_result sfield_merge(const sfield_field *const *shards, size_t count,
                                      const sfield_system *system, sfield_field **out);
/* Joins the shards of one field, given in the order of their shells, from the first shell to the last. The
   bytes are those of the whole build. system may be NULL.
   Errors   SFIELD_ERR_ARGUMENT (a pointer is NULL, or count is 0), SFIELD_ERR_DESC (allocator),
            SFIELD_ERR_MISMATCH (these are not the shards of one field), SFIELD_ERR_LIMIT (more wavelets than
            one field has), SFIELD_ERR_ALLOC, SFIELD_ERR_CANCELLED */
#endif

typedef enum sfield_kind {          /* what a field holds */
    SFIELD_KIND_NONE,
    SFIELD_KIND_OCCLUSION,          /* what an object hides from points round it */
    SFIELD_KIND_SOURCE,             /* what a light radiates to points round it */
    SFIELD_KIND_SELF,               /* what an object hides from points on it: sfield_build_self */
    SFIELD_KIND_COUNT
} sfield_kind;

typedef struct sfield_info {        /* most fields are those of sfield_desc, with defaults in place of 0 */
    sfield_kind    kind;
    sfield_basis   basis;
    uint32_t       bands;
    uint32_t       cube_side;
    uint32_t       shell_count;
    uint32_t       position_side;
    uint32_t       frame_count;
    sfield_spacing spacing;
    int            logarithm;
    size_t         sample_count;    /* cubes that were recorded; of self-visibility: points */
    uint64_t       coefficient_count;   /* wavelets in all of these cubes */
    size_t         bytes;           /* of the field, in memory and as a file */
    float          center[3], radius;
    float          inscribed;       /* radius of a sphere about the centre inside the closed mesh; 0 = none is
                                       known */
    float          inner, outer;    /* radii of the first and last shell, in radii of the bounding sphere */
    uint32_t       shard_begin, shard_end; /* 0, 0: the field is whole */
} sfield_info;

SFIELD_DEF void sfield_get_info(const sfield_field *field, sfield_info *out);
/* Writes what a field is. If field or out is NULL, nothing is written. */

SFIELD_DEF sfield_result sfield_query(const sfield_field *field, size_t count, const float *positions,
                                      float time, float *out);
/* Interpolates what is seen from positions, each between eight samples of the field.
   positions  three floats each, in the field's own space. From a position that is not finite nothing is seen:
              visibility 1, radiance 0
   time       seconds, of a source with frames
   out        visibility (or its logarithm, if that is stored) or radiance, for one position after the other:
              bands^2 coefficients or, with wavelets, 6 N^2 texels; of sources of r, then of g, then of b
   Errors     SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_MISMATCH (self-visibility, a shard) */

#ifndef SFIELD_WITHOUT_TABLES
SFIELD_DEF sfield_result sfield_self(const sfield_field *field, size_t first, size_t count, float *out);
/* Writes the self-visibility of count points from point `first` on, as it is stored.
   out      for each point bands^2 coefficients or, with wavelets, 6 N^2 texels
   Errors   SFIELD_ERR_ARGUMENT (NULL, points beyond the last), SFIELD_ERR_MISMATCH (a field of another
            kind) */
#endif

SFIELD_DEF sfield_result sfield_ambient(const sfield_field *field, size_t count, const float *positions,
                                        float *out);
/* Writes the share of all directions that an object leaves open at each position, 0..1: one float each, for
   ambient occlusion. With harmonics the first coefficient alone is read, which makes this much cheaper than
   sfield_query.
   positions  three floats each, in the field's own space; one that is not finite gets 1
   Errors     SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_MISMATCH (not an occlusion field, one of logarithms, a
              shard) */

SFIELD_DEF size_t sfield_bytes(const sfield_field *field);
/* Returns how many bytes sfield_write needs; 0 for NULL. */

SFIELD_DEF sfield_result sfield_write(const sfield_field *field, void *memory, size_t memory_bytes);
/* Writes a field as a file into your memory, little-endian: docs/shadowfield-format.md describes the bytes.
   Errors  SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_MEMORY (memory_bytes is below sfield_bytes) */

SFIELD_DEF sfield_result sfield_open(const void *data, size_t bytes, const sfield_system *system,
                                     sfield_field **out);
/* Makes a field from a file in memory, of which nothing is needed afterwards. Every size, offset, index and
   number in the file is checked. It takes `bytes` of memory, and up to 18,000 more. system may be NULL.
   Errors  SFIELD_ERR_ARGUMENT (data or out is NULL), SFIELD_ERR_DESC (allocator), SFIELD_ERR_FORMAT (not a
           file of this header, or a damaged one), SFIELD_ERR_VERSION (a file of an unknown version),
           SFIELD_ERR_MISMATCH (wavelets, in a header joined without them), SFIELD_ERR_ALLOC,
           SFIELD_ERR_CANCELLED */

/* ==== src/shadowfield/api_scenes.h ==== */

/* ---- scenes ---- */

typedef enum sfield_product_mode {  /* how the visibilities of several entities are multiplied */
    SFIELD_PRODUCT_DEFAULT,         /* = TRIPLE for harmonics, TEXELS for wavelets */
    SFIELD_PRODUCT_TRIPLE,          /* harmonics: every product is projected on the same bands again */
    SFIELD_PRODUCT_EXP,             /* harmonics: logarithms are added, and the sum's exponential is taken
                                       once for each light. The fields must have been built with
                                       desc.logarithm */
    SFIELD_PRODUCT_TEXELS,          /* wavelets: expanded where they have detail, multiplied on texels */
    SFIELD_PRODUCT_SPARSE,          /* wavelets: the paper's sublinear product of coefficients. Rotated
                                       entities may receive light, but neither hide nor shine, nor have a
                                       self-visibility */
    SFIELD_PRODUCT_COUNT
} sfield_product_mode;

typedef struct sfield_scene_desc {  /* zero it, then set what you care about */
    sfield_system       system;         /* kept: the scene's later calls use it too */
    sfield_basis        basis;          /* of all fields of the scene */
    uint32_t            bands;          /* of harmonics, 1..8; 0 = 4. Fields must have as many */
    uint32_t            cube_side;      /* texels a side of a cube's face, a power of two, 4..64. Wavelets: as
                                           the fields have; 0 = 32. Harmonics: of the environment; 0 = 16 */
    sfield_product_mode product;
    float               reach;          /* occluders count up to this many radii of their bounding sphere,
                                           0..1e6, and fade over the last quarter of that way (the paper's
                                           third culling rule); 0 = the outermost shell of each field */
    int                 strict;         /* not 0: sfield_scene_entities fails if the bounding sphere of a
                                           light overlaps that of an object */
} sfield_scene_desc;

typedef struct sfield_scene_stats { /* what sfield_shade counted */
    uint64_t points;                /* points that were shaded; those left out by `in_view` do not count */
    uint64_t pairs;                 /* pairs of a point and an occluder on which the point does not lie */
    uint64_t culled_far;            /* pairs left out because the occluder is out of reach */
    uint64_t culled_horizon;        /* pairs left out because the occluder lies below the point's horizon */
    uint64_t culled_hidden;         /* pairs left out because nearer occluders hide this one */
    uint64_t products;              /* multiplications of a point's T by the visibility of an occluder */
    uint64_t lights;                /* dot products of a point's T with a light */
    uint64_t reused;                /* those of `lights` whose T came from the cache */
    uint32_t overlaps;              /* pairs of a light and an object whose bounding spheres overlap */
    uint32_t rooms;                 /* those of them whose light lies in the object's convex hull, by its
                                       field: the object is taken for a convex room, which hides the light
                                       from no point in the hull, and may from all others. In a hollow that is
                                       not convex light goes through corners. Objects whose fields hold
                                       logarithms are no rooms, and there are none where `overlaps` is above
                                       65,536 */
} sfield_scene_stats;

SFIELD_DEF sfield_result sfield_scene_turn(sfield_scene *scene, const float to_world[16]);
/* Gives the same environment another rotation, from the map's space to the world; all 0 = none. It costs the
   rotation of 3 vectors of coefficients, or of one cube map.
   Errors   SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_INPUT (not a rotation) */

SFIELD_DEF sfield_result sfield_scene_sun(sfield_scene *scene, const float direction[3],
                                          const float irradiance[3]);
/* Adds a sun, light from one direction, to the environment. sfield_scene_turn does not turn suns. To move a
   sun take all of them away and add them anew; the map stays.
   direction    unit, towards the sun, in the world; NULL takes all suns away
   irradiance   r, g, b of a surface that faces the sun, 0..1e18 W/m^2
   Errors   SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_INPUT (a vector that is not unit, irradiance) */

#ifndef SFIELD_WITHOUT_TABLES
SFIELD_DEF sfield_result sfield_scene_sky(const sfield_scene *scene, float *coefs);
/* Writes the environment and its suns as they are now, for shaders: bands^2 coefficients of r, then of g,
   then of b; of a scene of wavelets 6 cube_side^2 texels of each.
   Errors   SFIELD_ERR_ARGUMENT (NULL) */
#endif

#ifndef SFIELD_WITHOUT_CACHE
SFIELD_DEF sfield_result sfield_cache_create(const sfield_scene *scene, size_t point_count,
                                             uint32_t light_count, sfield_cache **out);
/* Makes room in which a set of points keeps, from frame to frame, its T for each light: lazy occlusion
   updating (section 4.2). The next sfield_shade fills the cache; then only what has changed is computed anew:
   T of a point and a light is kept until an occluder between the two moves, comes or goes, or the entity that
   the point lies on moves. A light that moves keeps its T as long as it passes no occluder. Points get the
   results of the frame before, at the cost of a copy, if only occluders out of their reach moved since. The
   cache notices all that by itself, and another scene, `entity` or `self` of the set.
   With gloss the T of all kernels is kept, until to_eye, exponents or materials change: what stands before a
   moving eye is computed anew. Give what is diffuse a set of its own if the eye moves and little else does.
   It does not notice positions and normals that you rewrite (a mesh that deforms, another level of detail):
   then free the cache and create another.
   point_count   of the set, 1..2^31 - 1
   light_count   1..65536 lights of the scene, of which the environment is one. Lights beyond keep nothing
   Memory   from the scene's allocator: with harmonics 4 bands^2 + 9 bytes for each point and light, and 19
            for each point; with wavelets, of which the 256 largest are kept, 1,036 bytes for each point and
            light, and 76 for each point. The first sfield_shade with exponents (materials) takes twice (three
            times) as much instead, and 24 bytes more for each point
   Errors   SFIELD_ERR_ARGUMENT (scene, which leaves no log, or out is NULL; a count is out of range),
            SFIELD_ERR_ALLOC (also if the bytes overflow a size_t) */

SFIELD_DEF void sfield_cache_free(sfield_cache *cache);
/* Takes back a cache and its memory. Accepts NULL. */

SFIELD_DEF size_t sfield_cache_bytes(const sfield_cache *cache);
/* Returns how much memory a cache holds; 0 for NULL. */
#endif

#ifndef SFIELD_WITHOUT_INCIDENT
SFIELD_DEF sfield_result sfield_incident(sfield_scene *scene, const sfield_points *set, float *coefs);
/* Computes the radiance that arrives at points, as coefficients, for materials of your own. Entities are
   taken from far to near, so that occluders which several lights have in common are applied once (section
   3.2); those of a light that lies in a room (sfield_scene_stats.rooms) for it alone.
   set      the arrays for results are not written; normals must be there, but all directions count, whatever
            the normal. Self-visibility and BRDF are not applied
   coefs    bands^2 coefficients of r, then of g, then of b for each point, in world space
   Errors   as sfield_shade; SFIELD_ERR_MISMATCH also for wavelets and SFIELD_PRODUCT_EXP */
#endif

/* ==== src/shadowfield/api_sparse.h ==== */

/* ---- sparse vertices: shade few, interpolate the rest ---- */

SFIELD_DEF sfield_result sfield_sparse(const sfield_points *points, float spacing,
                                       const sfield_system *system, uint32_t *chosen, size_t *chosen_count,
                                       uint32_t *sources, float *weights);
/* Chooses the points of an object far from the eye that are worth shading: about one for each cube of edge
   `spacing` and side of the surface. Shade these alone, then call sfield_spread.
   points   count (1..2^31 - 1), positions and normals (any length) with their strides; the other members are
            not read
   spacing  world units, > 0
   system   NULL = malloc and free
   chosen   room for count numbers; *chosen_count numbers of points are written, cube by cube
   sources  for each point the places of 3 points in `chosen`
   weights  for each point the 3 weights of these; their sum is 1
   Errors   SFIELD_ERR_ARGUMENT (a pointer is NULL, there are no points, or a stride or spacing is out of
            range), SFIELD_ERR_INPUT (a point that is not finite, or farther than 1e9 spacings from the
            origin), SFIELD_ERR_LIMIT (2^31 points), SFIELD_ERR_DESC (allocator), SFIELD_ERR_ALLOC
   Cost     O(count log count), 40 bytes a point */

SFIELD_DEF sfield_result sfield_spread(size_t count, const uint32_t *sources, const float *weights,
                                       size_t chosen_count, const float *rgb, float *out);
/* Interpolates shaded points for all others: out[i] is the sum of the rgb of the three sources of point i,
   times their weights.
   sources, weights   as sfield_sparse writes them, for count points
   rgb      3 floats for each of the chosen_count points that were shaded
   out      3 floats for each of count points; not rgb
   Errors   SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_INPUT (a source is not below
            chosen_count). There is no log */

/* ==== src/shadowfield/api_harmonics.h ==== */

/* ---- spherical harmonics ---- */

/* Coefficient number l^2 + l + m belongs to band l, 0 <= l < bands. Functions that take `stride` work on
   count vectors at a time, in planes: coefficient k of vector i is v[k * stride + i], and stride >= count. A
   single plain vector has count 1 and stride 1. */

#define SFIELD_MAX_BANDS 8u
#define SFIELD_MAX_COEFS 64u

typedef struct sfield_algebra sfield_algebra;      /* tables of one number of bands; read-only once made */

SFIELD_DEF sfield_result sfield_algebra_create(uint32_t bands, const sfield_system *system,
                                               sfield_algebra **out);
/* Makes the tables for 1..8 bands. system may be NULL.
   Errors  SFIELD_ERR_ARGUMENT (out is NULL, or bands is out of range), SFIELD_ERR_DESC (allocator),
           SFIELD_ERR_ALLOC
   Cost    1 to 100 ms, 0.1 to 1 MB */
SFIELD_DEF void sfield_algebra_free(sfield_algebra *algebra);
/* Takes back tables and their memory. Accepts NULL. */

SFIELD_DEF void sfield_sh_basis(uint32_t bands, const double direction[3], double *y);
/* Writes the values of the bands^2 real basis functions at a unit direction. Nothing is checked.
   bands   1..8 */

typedef struct sfield_rotation {    /* a rotation of functions, from sfield_sh_rotation */
    uint32_t bands;
    int      identity;              /* not 0: the rotation is none */
    float    block[680];            /* (2l+1) x (2l+1) floats for each band l, by rows */
} sfield_rotation;

SFIELD_DEF sfield_result sfield_sh_rotation(const sfield_algebra *algebra, const float matrix[16],
                                            sfield_rotation *out);
/* Makes the matrices that turn a function f(w) into f(R^-1 w): what f has in direction w goes to R w.
   matrix  R, a rotation, which may be multiplied by one scale > 0; its translation is ignored
   Errors  SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_INPUT (matrix)
   Cost    2 us (4 bands) to 50 us (8): once for each entity and frame, not for each vector */

SFIELD_DEF void sfield_sh_window(uint32_t bands, float strength, float factors[SFIELD_MAX_BANDS]);
/* Writes factors for each band l against ringing, 1 / (1 + strength l^2 (l+1)^2).
   bands   1..8; of more, eight factors are written */

SFIELD_DEF void sfield_sh_cosine(uint32_t bands, float factors[SFIELD_MAX_BANDS]);
/* Writes factors for each band, those of max(0, cos): coefficients of radiance times these are coefficients
   of irradiance. bands as in sfield_sh_window. */

/* ---- cubes ---- */

SFIELD_DEF float sfield_cube_texel(uint32_t side, uint32_t texel, float direction[3]);
/* Writes the unit direction of a texel's centre and returns the texel's solid angle in sr. Returns 0 and
   writes nothing if an argument is out of range.
   side    a power of two, 2..64
   texel   below 6 side^2: number face side^2 + morton(x, y) */

SFIELD_DEF uint32_t sfield_cube_find(uint32_t side, const float direction[3]);
/* Returns the texel that a direction of any length falls into; 0 if an argument is out of range. */

SFIELD_DEF sfield_result sfield_sh_project(uint32_t bands, uint32_t side, const float *texels,
                                           uint32_t channels, float *coefs);
/* Projects a cube of texels on the basis, exactly over each texel.
   side      a power of two, 2..64
   texels    6 side^2 texels of `channels` (1..3) floats each
   coefs     bands^2 for each channel, one channel after the other
   Errors    there is no log. SFIELD_ERR_ARGUMENT (a pointer is NULL, or a number is out of range) */

/* ==== src/shadowfield/api_harmonics_tools.h ==== */

/* ---- spherical harmonics of your own: what no scene needs ---- */

SFIELD_DEF sfield_result sfield_sh_product(const sfield_algebra *algebra, size_t count, const float *a,
                                           const float *b, float *out, size_t stride);
/* Multiplies two functions, count pairs at a time: out is a b, projected on the bands that a and b have. All
   tripling coefficients are used (section 4.1 of the paper), so that only the bands above are lost.
   a, b, out  vectors in planes; out may be a or b
   Errors     SFIELD_ERR_ARGUMENT (a pointer is NULL, which leaves no log if it is algebra; stride is below
              count)
   Cost       about 10 ns a product with 4 bands and AVX2, 5 ns with 3: docs/measured/performance.md */

SFIELD_DEF size_t sfield_sh_terms(const sfield_algebra *algebra, uint32_t *terms, float *factors);
/* Lists the terms of sfield_sh_product, for shaders that multiply functions themselves, and returns how many
   there are. A term says out_k += factor (a_i b_j + a_j b_i), of which only one half is added if i = j. The
   list has i >= j >= 1 and k >= 1 alone; what has an index 0 is simple: out_k += 0.2821 (a_0 b_k + a_k b_0)
   for k >= 1, and out_0 is 0.2821 times the dot product of a and b.
   terms     i | j << 8 | k << 16, rising in k
   factors   one for each term; if terms or factors is NULL, nothing is written */

SFIELD_DEF sfield_result sfield_sh_dot(uint32_t bands, size_t count, const float *a, const float *b,
                                       float *out, size_t stride);
/* Writes out[i], the integral of a_i b_i over the sphere, which is the dot product of their coefficients.
   a, b     vectors of bands^2 coefficients (bands 1..8), in planes
   out      count floats
   Errors   there is no log. SFIELD_ERR_ARGUMENT (a pointer is NULL, bands is out of range, or stride is below
            count) */

SFIELD_DEF sfield_result sfield_sh_rotate(const sfield_rotation *rotation, size_t count, const float *in,
                                          float *out, size_t stride);
/* Turns count vectors, in planes. out may be in.
   Errors   there is no log. SFIELD_ERR_ARGUMENT (a pointer is NULL, stride is below count, or the rotation
            was not made by sfield_sh_rotation) */

SFIELD_DEF sfield_result sfield_sh_product_n(uint32_t bands, uint32_t functions, const float *coefs,
                                             const sfield_system *system, double *out);
/* Multiplies several functions exactly, as a reference: on a grid that is fine enough for the full product,
   of which the lowest bands are then projected. sfield_sh_product projects after each of its products
   instead.
   bands      1..8
   functions  1..32
   coefs      bands^2 floats of each function, one function after the other
   system     may be NULL
   out        bands^2 coefficients of the product, whose integral is sqrt(4 pi) out[0]
   Errors     SFIELD_ERR_ARGUMENT (coefs or out is NULL; bands or functions is out of range), SFIELD_ERR_DESC
              (allocator), SFIELD_ERR_ALLOC */

SFIELD_DEF sfield_result sfield_sh_log(const sfield_algebra *algebra, const float *visibility, float *out);
/* Computes the logarithm of one vector by the eigenvalues of its product matrix, which are clipped below at
   0.02. A product of visibilities is the exponential of the sum of their logarithms, in any order (Ren et
   al., SIGGRAPH 2006).
   Errors   SFIELD_ERR_ARGUMENT (a pointer is NULL, which leaves no log if it is algebra), SFIELD_ERR_ALLOC */

SFIELD_DEF sfield_result sfield_sh_exp(const sfield_algebra *algebra, size_t count, const float *in,
                                       float *out, size_t stride);
/* Computes the exponentials of vectors in planes, by scaling and squaring.
   Errors   as sfield_sh_product */

SFIELD_DEF float sfield_sh_window_fit(uint32_t bands, const float *coefs, float lowest);
/* Returns the least strength, 0..1, with which a function stays >= lowest in each of 2,592 directions.
   Returns 1 also if no strength is enough, as for a function whose mean is below lowest, and 0 for bad
   arguments. */

SFIELD_DEF sfield_result sfield_cube_basis(uint32_t bands, uint32_t side, uint32_t texel, float *out);
/* Writes the exact integrals of the bands^2 basis functions over one texel. The sum over all texels of value
   x these integrals are a function's coefficients: a table for projection elsewhere, as on a GPU.
   Errors  there is no log. SFIELD_ERR_ARGUMENT (out is NULL, or a number is out of range) */

/* ==== src/shadowfield/api_wavelets.h ==== */

/* ---- Haar wavelets ---- */

/* The 6 side^2 coefficients of a cube come face by face. On a face, [0] is the scaling coefficient, and
   [4^j + 3 node + t] is wavelet t (0 in x, 1 in y, 2 in both) of square `node` of level j. */

SFIELD_DEF sfield_result sfield_haar_forward(uint32_t side, const float *texels, float *coefs);
SFIELD_DEF sfield_result sfield_haar_inverse(uint32_t side, const float *coefs, float *texels);
/* Transform all six faces in 2D, and back. The basis is orthonormal over the texels of the planar face, so
   that solid angles play no part.
   side           a power of two, 2..64
   texels, coefs  6 side^2 floats each, not the same array
   Errors         there is no log. SFIELD_ERR_ARGUMENT (a pointer is NULL, side is out of range, or both
                  arrays are one) */

SFIELD_DEF sfield_result sfield_haar_product(uint32_t side, const float *a, const float *b, float *out);
/* Multiplies two functions that are given by their coefficients (Ng, Ramamoorthi and Hanrahan, SIGGRAPH
   2004).
   a, b, out  6 side^2 coefficients each; out is another array
   Errors     there is no log. SFIELD_ERR_ARGUMENT (a pointer is NULL, side is out of range, or out is a or b)
   Cost       grows with the coefficients that are not 0, not with the texels: a square without any is not
              walked into */

/* ==== src/shadowfield/api_gloss.h ==== */

/* ---- BRDFs as harmonics ---- */

SFIELD_DEF size_t sfield_sh_brdf(uint32_t bands, const sfield_system *system, float *table);
/* Writes the kernels of glTF's metal-rough BRDF as harmonics, for shaders: of points that have `materials`
   sfield_shade interpolates the same table. docs/shadowfield.md says what the kernels are.
   bands    1..8
   system   its parallel_for alone is used; NULL = this thread
   table    for each of 24 roughnesses, 0 to 1, and 48 views, whose sqrt(1 - cosine) goes from 0 to 1: three
            kernels times the cosine, then three without it; of each the bands (bands + 1) / 2 coefficients of
            order m >= 0, band by band. NULL = nothing is written
   Returns  how many floats the table has, 6,912 times bands (bands + 1) / 2; 0 for other bands
   Cost     0.2 s (4 bands) to 0.5 s (8) of one core */

/* ==== src/shadowfield/api_bounces.h ==== */

/* ---- one interreflection between bodies ---- */

#ifndef SFIELD_WITHOUT_BUILD
typedef struct sfield_bounce sfield_bounce;     /* what a diffuse body sends on of the light that it gets */

SFIELD_DEF sfield_result sfield_bounce_create(const sfield_desc *desc, const sfield_mesh *mesh,
                                              const float *albedo, uint32_t patch_count, sfield_bounce **out);
/* Cuts the surface of a body into patches and builds a source field of each, once for each body. Then, in
   each frame: shade the points of all bodies, give each body its results (sfield_bounce_update), let its
   entity have the source (sfield_bounce_source, tint 1 1 1), and shade what is to be seen. The body's own
   points are not lit by its source. If the entities had the sources of the last frame when the points were
   shaded, each frame adds a bounce; for one bounce alone give the scene entities without these sources first.
   desc         as for the body's occlusion field; harmonics, of visibility. A shell_count and position_side
                of 8 are enough, since what bodies send on is soft. Frames and shards are not read
   mesh         the body. Light leaves the side from which corners are counter-clockwise. A triangle belongs
                to one patch: what is large has to be cut
   albedo       r, g, b of each triangle, 0..1
   patch_count  1..192; 0 = 24. There may be fewer, if triangles are few
   out          written on SFIELD_OK only; sfield_bounce_free takes the bounce back
   Errors       as sfield_build_emissive; SFIELD_ERR_ARGUMENT also for patch_count and NULL, SFIELD_ERR_INPUT
                for an albedo and for a mesh without an area, SFIELD_ERR_DESC also for wavelets and logarithms
   Cost         a source field for every three patches, in time and memory: for each patch shells x
                6 side^2 x n bytes, with n = bands^2 filled up to a multiple of 8. Beside them the source,
                which is as large as three patches, and 72 side^2 x n bytes */

SFIELD_DEF void sfield_bounce_free(sfield_bounce *bounce);
/* Takes back a body's patches and their source. Accepts NULL. */

SFIELD_DEF void sfield_bounce_points(const sfield_bounce *bounce, sfield_points *out);
/* Writes the receivers at which light has to be known, four a patch: count, positions and normals in the
   space of the body; all else is 0. Set `entity` and `rgb`, and `self` for a body that hides something of
   itself. If bounce or out is NULL, nothing is written. */

SFIELD_DEF sfield_result sfield_bounce_update(sfield_bounce *bounce, const float *rgb);
/* Makes the source of the body from the light that it gets, on this thread. No other thread may shade a scene
   that has the source meanwhile, since the same field is rewritten.
   rgb      results of sfield_shade for the points, 3 floats each; what is negative or not finite counts as
            0, what is above 1e18 as 1e18
   Errors   SFIELD_ERR_ARGUMENT (NULL)
   Cost     for each patch about that of copying its part of the field */

SFIELD_DEF const sfield_field *sfield_bounce_source(const sfield_bounce *bounce);
/* Returns the source field, dark before the first sfield_bounce_update; NULL for NULL. It belongs to the
   bounce: do not free it. The pointer stays the same. Call sfield_scene_entities after each update, so that
   caches notice. */
#endif

/* ==== src/shadowfield/begin.h ==== */

#ifdef __cplusplus
}
#endif

#endif /* SHADOWFIELD_H */

/* ==== implementation ==================================================================================== */

#if defined(SHADOWFIELD_IMPLEMENTATION) && !defined(SHADOWFIELD_IMPLEMENTED)

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The name by which this file includes itself (see kernels_begin.h). Define SFIELD_FILE if you renamed it. */
#ifndef SFIELD_FILE
#define SFIELD_FILE "shadowfield.h"
#endif
#define SFIELD__FILE SFIELD_FILE

#ifdef SFIELD_NO_SIMD
#define SFIELD__NO_SIMD
#define SFIELD__COMPILER_VECTORS
#endif

/* ==== src/shared/fp_begin.h ==== */

/* unit fp_begin: the arithmetic that the bytes depend on, from here to unit fp_end */

/* Forbids fused multiply-adds that the source does not ask for: gcc fuses across statements in its gnu modes
   and on s390x, clang within expressions. For gcc, the pragmas take a user's -ffast-math back. In clang,
   -ffast-math and -ffp-contract=fast win over the pragma: results then stay within tolerance, but are not
   equal to the bit. */
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#define SFIELD__FINITE_MATH 1
#else
#define SFIELD__FINITE_MATH 0
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && !defined(__TINYC__)
#pragma GCC push_options
#pragma GCC optimize("-ffp-contract=off", "-fno-fast-math", "-fno-trapping-math")
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif

/* ==== src/shared/mem.h ==== */

/* unit mem: checked sizes, and the caller's allocator with malloc and free as its default */

typedef struct sfield__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} sfield__allocator;

static inline void *sfield__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void sfield__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
static inline int sfield__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

/* Returns 1 if so many bytes may lie between elements of floats that are `standard` bytes large: 0, which
   stands for `standard`, or a multiple of 4 with which elements do not overlap. */
static inline int sfield__stride_valid(size_t stride, size_t standard)
{
    return stride == 0 || (stride >= standard && stride % 4 == 0);
}

/* Returns 1 if the functions of a public allocator are both there or both NULL. */
static inline int sfield__allocator_valid(void *(*alloc_fn)(size_t, void *), void (*free_fn)(void *, void *))
{
    return (alloc_fn == NULL) == (free_fn == NULL);
}

static inline sfield__allocator sfield__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    sfield__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : sfield__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : sfield__default_free;
    a.user = user;
    return a;
}

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *sfield__alloc(const sfield__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *sfield__alloc_array(const sfield__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return sfield__mul_size(count, item_size, &size) ? sfield__alloc(a, size) : NULL;
}

static inline void sfield__free(const sfield__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/v3.h ==== */

/* unit v3: three floats */

/* tcc 0.9.27 stores a returned struct of 12 bytes as 16, over the caller's next variable. */
typedef struct sfield__v3 {
    float x, y, z;
#ifdef __TINYC__
    float unused;
#endif
} sfield__v3;

static inline sfield__v3 sfield__v3_make(float x, float y, float z)
{
    sfield__v3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

static inline sfield__v3 sfield__v3_load(const float *p) { return sfield__v3_make(p[0], p[1], p[2]); }
static inline void sfield__v3_store(float *p, sfield__v3 v) { p[0] = v.x; p[1] = v.y; p[2] = v.z; }

static inline sfield__v3 sfield__v3_add(sfield__v3 a, sfield__v3 b)
{
    return sfield__v3_make(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline sfield__v3 sfield__v3_sub(sfield__v3 a, sfield__v3 b)
{
    return sfield__v3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline sfield__v3 sfield__v3_scale(sfield__v3 a, float s)
{
    return sfield__v3_make(a.x * s, a.y * s, a.z * s);
}

/* Returns a + b s. */
static inline sfield__v3 sfield__v3_madd(sfield__v3 a, sfield__v3 b, float s)
{
    return sfield__v3_make(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s);
}

static inline float sfield__v3_dot(sfield__v3 a, sfield__v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float sfield__v3_length(sfield__v3 a)
{
    return sqrtf(sfield__v3_dot(a, a));
}

static inline sfield__v3 sfield__v3_cross(sfield__v3 a, sfield__v3 b)
{
    return sfield__v3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline sfield__v3 sfield__v3_min(sfield__v3 a, sfield__v3 b)
{
    return sfield__v3_make(a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z);
}

static inline sfield__v3 sfield__v3_max(sfield__v3 a, sfield__v3 b)
{
    return sfield__v3_make(a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z);
}

/* Returns a with length 1. The largest component scales the others first, so that neither tiny nor huge
   vectors leave the range of floats. The zero vector stays zero. */
static inline sfield__v3 sfield__v3_normalize(sfield__v3 a)
{
    float x = fabsf(a.x), y = fabsf(a.y), z = fabsf(a.z), m = x > y ? x : y;
    m = m > z ? m : z;
    if (!(m > 0.0f)) return sfield__v3_make(0.0f, 0.0f, 0.0f);
    if (m < 1e-30f) {
        a = sfield__v3_scale(a, 1e30f);
        m *= 1e30f;
    }
    a = sfield__v3_make(a.x / m, a.y / m, a.z / m);
    m = sfield__v3_length(a);
    return sfield__v3_make(a.x / m, a.y / m, a.z / m);
}

/* Returns 1 if x is finite, by its exponent bits: under -ffast-math compilers may take isfinite() for always
   true. */
static inline int sfield__finite(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7f800000u) != 0x7f800000u;
}

static inline int sfield__in(float x, float low, float high) { return sfield__finite(x) && x >= low && x <= high; }

static inline int sfield__v3_finite(sfield__v3 a)
{
    return sfield__finite(a.x) && sfield__finite(a.y) && sfield__finite(a.z);
}

/* ==== src/shared/unit.h ==== */

/* unit unit: which vectors count as unit, the same in every header (src/README.md, "Unit vectors") */

/* The squares of the least and the greatest length that count as 1: an 8-bit normal map makes such
   vectors. */
#define SFIELD__UNIT_LEAST2 0.9409f       /* 0.97^2 */
#define SFIELD__UNIT_MOST2 1.0609f        /* 1.03^2 */

/* Says whether a vector is unit, by the square of its length. If that is not a number, the vector is not. */
static inline int sfield__is_unit2(float length2)
{
    return length2 >= SFIELD__UNIT_LEAST2 && length2 <= SFIELD__UNIT_MOST2;
}

/* ==== src/shared/m4.h ==== */

/* unit m4, needs v3: column-major 4 x 4 matrices, float[16], affine */

static inline sfield__v3 sfield__m4_point(const float *m, sfield__v3 p)
{
    return sfield__v3_make(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12],
                     m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                     m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]);
}

/* Returns m, or the identity if all sixteen numbers are 0: so a struct that was zeroed stands where it is. */
static inline const float *sfield__m4_or_identity(const float *m)
{
    static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    int i;
    for (i = 0; i < 16; i++)
        if (m[i] != 0.0f) return m;         /* so does NaN, for others to refuse */
    return identity;
}

/* Returns 1 if a matrix is finite and its last row is 0 0 0 1. */
static inline int sfield__m4_is_affine(const float *m)
{
    int i;
    for (i = 0; i < 16; i++)
        if (!sfield__finite(m[i])) return 0;
    return m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f && m[15] == 1.0f;
}

/* Returns 1 and writes *scale if m is a rotation times one scale > 0, without mirroring, and a translation.
   Its columns must be of equal length and at right angles within 1e-4, which products of float rotations
   reach. */
static inline int sfield__m4_is_rigid_uniform(const float *m, float *scale)
{
    sfield__v3 x = sfield__v3_load(m), y = sfield__v3_load(m + 4), z = sfield__v3_load(m + 8);
    float lx, ly, lz;
    float s, tolerance;

    if (!sfield__m4_is_affine(m)) return 0;
    lx = sfield__v3_length(x);
    ly = sfield__v3_length(y);
    lz = sfield__v3_length(z);
    if (!(lx > 0.0f && ly > 0.0f && lz > 0.0f) || !sfield__finite(lx + ly + lz)) return 0;
    s = (lx + ly + lz) / 3.0f;
    tolerance = 1e-4f * s;
    if (fabsf(lx - s) > tolerance || fabsf(ly - s) > tolerance || fabsf(lz - s) > tolerance) return 0;
    x = sfield__v3_scale(x, 1.0f / lx);
    y = sfield__v3_scale(y, 1.0f / ly);
    z = sfield__v3_scale(z, 1.0f / lz);
    if (fabsf(sfield__v3_dot(x, y)) > 1e-4f || fabsf(sfield__v3_dot(x, z)) > 1e-4f) return 0;
    if (fabsf(sfield__v3_dot(y, z)) > 1e-4f ||
        sfield__v3_dot(sfield__v3_cross(x, y), z) < 0.0f) return 0;
    *scale = s;
    return 1;
}

/* ==== src/shared/bytes.h ==== */

/* unit bytes: little-endian values in byte arrays, whatever the host's order and alignment */

static inline void sfield__put_u16(uint8_t *p, uint32_t v)
{
    p[0] = (uint8_t)(v & 255u);
    p[1] = (uint8_t)(v >> 8 & 255u);
}

static inline void sfield__put_u32(uint8_t *p, uint32_t v)
{
    sfield__put_u16(p, v & 0xffffu);
    sfield__put_u16(p + 2, v >> 16);
}

static inline uint32_t sfield__get_u32(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static inline int sfield__host_is_little_endian(void)
{
    uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 1;
}

/* ==== src/shared/crc.h ==== */

/* unit crc: CRC-32 as in zip and PNG (reflected 0xEDB88320) */

/* Returns the checksum of data that follows data with the checksum crc; crc is 0 for the first piece. The
   table has 16 entries: four bits a step are fast enough for files, and the table is small enough to read. */
static inline uint32_t sfield__crc32(uint32_t crc, const void *data, size_t size)
{
    static const uint32_t table[16] = {
        0x00000000u, 0x1db71064u, 0x3b6e20c8u, 0x26d930acu, 0x76dc4190u, 0x6b6b51f4u,
        0x4db26158u, 0x5005713cu, 0xedb88320u, 0xf00f9344u, 0xd6d6a3e8u, 0xcb61b38cu,
        0x9b64c2b0u, 0x86d3d2d4u, 0xa00ae278u, 0xbdbdf21cu
    };
    const uint8_t *p = (const uint8_t *)data;
    size_t i;

    crc = ~crc;
    for (i = 0; i < size; i++) {
        crc ^= p[i];
        crc = crc >> 4 ^ table[crc & 15u];
        crc = crc >> 4 ^ table[crc & 15u];
    }
    return ~crc;
}

/* ==== src/shared/trig.h ==== */

/* unit trig: elementary functions with the same bits on every machine */

/* These functions use + - * / and sqrt alone, which IEEE 754 rounds the same everywhere as long as nothing
   is contracted (unit fp_begin). Coefficients are minimax fits of our own. The float functions are free of
   branches and calls, so that loops over them vectorise at SSE2 level. The errors named below are the
   largest differences from the double functions, over all float arguments or a dense set
   (tests/shared/units_test.c). Arguments out of range and NaN are clamped into the range, so that nothing
   here is undefined or returns NaN. */

static inline float sfield__from_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline uint32_t sfield__to_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* Returns |x| with the sign bit of s; s = -0 counts as negative. */
static inline float sfield__copysign(float x, float s)
{
    return sfield__from_bits((sfield__to_bits(x) & 0x7fffffffu) | (sfield__to_bits(s) & 0x80000000u));
}

/* Writes sine and cosine of |x| <= 8192 with an absolute error of 1e-7. As in Cody and Waite, pi/2 has three
   parts, of which the first two times k are exact for |k| < 2^13. */
static inline void sfield__sincos(float x, float *sine, float *cosine)
{
    float t, r, z;
    float s, c, a, b;
    int32_t k;

    t = x > -8192.0f ? x : -8192.0f;
    t = t < 8192.0f ? t : 8192.0f;
    k = (int32_t)(t * 0.636619772f + (t < 0.0f ? -0.5f : 0.5f));
    r = ((t - (float)k * 1.5703125f) - (float)k * 4.837512969970703125e-4f) -
        (float)k * 7.5497899548918822e-8f;
    z = r * r;
    s = r + r * z * (-0.1666665494f + z * (0.008332178146f + z * -0.0001951729898f));
    c = (1.0f - 0.5f * z) + z * z * (0.04166664687f + z * (-0.001388736752f + z * 2.443845159e-5f));
    a = k & 1 ? c : s;
    b = k & 1 ? s : c;
    *sine = k & 2 ? -a : a;
    *cosine = (k + 1) & 2 ? -b : b;
}

/* Returns asin of 0 <= x <= 0.5, with z = x * x. The functions made of it have an absolute error of 3e-7. */
static inline float sfield__asin_core(float x, float z)
{
    return x + x * z * (0.1666675393f + z * (0.07495241769f + z * (0.04547709903f + z * (0.02414760004f +
                        z * 0.04221856856f))));
}

static inline float sfield__asin(float x)
{
    float a = fabsf(x), h, s, p;
    a = a < 1.0f ? a : 1.0f;
    h = 0.5f * (1.0f - a);
    s = sqrtf(h);
    s = a > 0.5f ? s : a;
    p = sfield__asin_core(s, a > 0.5f ? h : a * a);
    return sfield__copysign(a > 0.5f ? 1.57079633f - 2.0f * p : p, x);
}

/* Returns exp(x) as 2^k (1 + r + r^2 p(r)) with |r| <= ln 2 / 2, in double, so that exp, log and pow err by
   1 ulp. */
static inline double sfield__exp_core(double x)
{
    double r, p, power;
    int32_t k;
    uint64_t bits;

    x = x > -110.0 ? x : -110.0;
    x = x < 90.0 ? x : 90.0;
    k = (int32_t)(x * 1.4426950408889634 + (x < 0.0 ? -0.5 : 0.5));
    r = x - (double)k * 0.69314718055994531;
    p = 0.00139460621285616904 + r * 0.000199183706518237736;
    p = 0.500000007785776445 + r * (0.166666668605852527 + r * (0.0416662700968242239 +
        r * (0.00833326438132814496 + r * p)));
    bits = (uint64_t)(k + 1023) << 52;
    memcpy(&power, &bits, sizeof power);
    return power * (1.0 + (r + r * r * p));
}

/* Returns the logarithm of x > 0 from x = 2^e m with m in [sqrt(1/2), sqrt(2)), by
   log m = 2 artanh((m - 1) / (m + 1)). */
static inline double sfield__log_core(float x)
{
    double m = (double)x, s, z;
    uint64_t bits;
    int32_t e;

    memcpy(&bits, &m, sizeof bits);
    e = (int32_t)(bits >> 52) - 1023;
    bits = (bits & 0x000fffffffffffffu) | 0x3ff0000000000000u;
    memcpy(&m, &bits, sizeof m);
    if (m > 1.4142135623730951) {
        m *= 0.5;
        e++;
    }
    s = (m - 1.0) / (m + 1.0);
    z = s * s;
    z *= 0.333333328227282264 + z * (0.200001675954362054 + z * (0.142686542711926518 +
         z * 0.117910756496012977));
    return (double)e * 0.69314718055994531 + 2.0 * (s + s * z);
}

/* Returns exp(x), which is infinity above 88.7228394. */
static inline float sfield__exp(float x)
{
    return x > 88.7228394f ? sfield__from_bits(0x7f800000u) : (float)sfield__exp_core((double)x);
}

/* Returns the natural logarithm of x, or -infinity if x is not above 0. */
static inline float sfield__log(float x)
{
    return x > 0.0f ? (float)sfield__log_core(x) : sfield__from_bits(0xff800000u);
}

/* Returns x^y. x below 0 counts as 0; 0^y is 0, 1 or infinity for y above, equal to or below 0. */
static inline float sfield__pow(float x, float y)
{
    double t;
    if (y == 0.0f) return 1.0f;
    if (!(x > 0.0f)) return y > 0.0f ? 0.0f : sfield__from_bits(0x7f800000u);
    t = (double)y * sfield__log_core(x);
    return t > 88.722839111 ? sfield__from_bits(0x7f800000u) : (float)sfield__exp_core(t);
}

/* ==== src/shared/cpu.h ==== */

/* unit cpu: run-time detection of x86 vector units */

/* SFIELD__X86 is 1 if functions with target attributes can be compiled and chosen at run time. SFIELD__NO_SIMD, which
   the header defines from its public switch, makes it 0. tcc has no such attributes, so that it is 0 there;
   MSVC needs none. For clang in MSVC's place (clang-cl) it is 0, since this compiler hides the vector types
   unless the whole program is built for them. */
#if defined(SFIELD__NO_SIMD) || defined(__TINYC__)
#define SFIELD__X86 0
#elif defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
#define SFIELD__X86 1
#define SFIELD__TARGET_AVX2 __attribute__((target("avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#define SFIELD__TARGET_AVX512 \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#elif defined(_MSC_VER) && defined(_M_X64) && !defined(__clang__)
#define SFIELD__X86 1
#define SFIELD__TARGET_AVX2
#define SFIELD__TARGET_AVX512
#else
#define SFIELD__X86 0
#endif

/* These ask the processor directly: the compilers' own functions ask the same, but add 4.5 KB to every
   program. */
#if SFIELD__X86 && defined(_MSC_VER)
#include <intrin.h>
static inline void sfield__cpu_ask(unsigned leaf, unsigned *r) { __cpuidex((int *)r, (int)leaf, 0); }
static inline unsigned sfield__cpu_xcr0(void) { return (unsigned)_xgetbv(0); }
#elif SFIELD__X86
#include <cpuid.h>
static inline void sfield__cpu_ask(unsigned leaf, unsigned *r)
{
    __cpuid_count(leaf, 0, r[0], r[1], r[2], r[3]);
}
static inline unsigned sfield__cpu_xcr0(void)
{
    unsigned low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}
#endif

#if SFIELD__X86
/* Returns 1 if all of these bits are set in ebx of cpuid's leaf 7, the processor has FMA and POPCNT, and the
   operating system saves the registers that the bits of xcr0 stand for. Every processor with BMI2 has
   LZCNT. */
static inline int sfield__cpu_leaf7(unsigned xcr0, unsigned ebx)
{
    const unsigned wanted = 1u << 12 | 1u << 23 | 1u << 27;     /* FMA, POPCNT, OSXSAVE */
    unsigned r[4];
    sfield__cpu_ask(0, r);
    if (r[0] < 7) return 0;
    sfield__cpu_ask(1, r);
    if ((r[2] & wanted) != wanted || (sfield__cpu_xcr0() & xcr0) != xcr0) return 0;
    sfield__cpu_ask(7, r);
    return (r[1] & ebx) == ebx;
}
/* Asks for AVX2, BMI and BMI2, and for the registers of SSE and AVX. */
static inline int sfield__cpu_has_avx2(void) { return sfield__cpu_leaf7(0x06u, 0x00000128u); }
/* Asks for F, DQ, BW and VL of AVX-512 besides, and for its mask registers and wide registers. */
static inline int sfield__cpu_has_avx512(void) { return sfield__cpu_leaf7(0xe6u, 0xc0030128u); }
#else
static inline int sfield__cpu_has_avx2(void) { return 0; }
static inline int sfield__cpu_has_avx512(void) { return 0; }
#endif

/* ==== src/shared/simd.h ==== */

/* unit simd, needs cpu: one text of a kernel for every instruction set */

/* A kernel is written once, for sfield__lanes: SFIELD__LANE_COUNT floats, of which the instruction set SFIELD__SET
   computes SFIELD__WIDTH at a time. What lies between unit simd_begin and the last kernel of a header is compiled
   once for every set that the program may meet. It is first compiled in its place, as set "plain", for what
   the whole program is compiled for (SSE2, NEON, the 128 bits of WebAssembly, or one float at a time). Then,
   if SFIELD__SIMD_SETS is 1, the header includes itself with SFIELD__SET, SFIELD__WIDTH and SFIELD__LANE_COUNT defined
   anew: avx2 with 8 lanes, avx512 with 16. sfield__simd_level returns which set to call. With SFIELD__NO_SIMD there
   are no intrinsics; the compiler's own vectors, which are portable, stay if SFIELD__COMPILER_VECTORS is
   defined. SFIELD__FILE is the header's name; a header pasted into another file cannot include itself: "plain".

   What is compiled several times needs a name for each set. The list below makes sfield__lanes_add the name
   sfield__lanes_add_avx2 in set avx2; the header has such a list for its kernels. SFIELD__KERNEL stands before a
   kernel, SFIELD__IN_KERNEL before what is inlined into kernels.

   Every set gives the same bits, but for sfield__lanes_muladd, which rounds once in avx2 and avx512, twice
   elsewhere. */
#if defined(SFIELD__NO_SIMD) && (!defined(SFIELD__COMPILER_VECTORS) || defined(__i386__))
#define SFIELD__SCALAR 1
#else
#define SFIELD__SCALAR 0
#endif
#if SFIELD__X86
#include <immintrin.h>
#define SFIELD__SIMD_SETS 1
#else
#define SFIELD__SIMD_SETS 0
#endif
#if SFIELD__X86 && (defined(__x86_64__) || defined(_M_X64))
#define SFIELD__SIMD_X86 1
#define SFIELD__SIMD_VECTORS 0
#define SFIELD__SIMD_WIDTH 4
#elif !SFIELD__X86 && !SFIELD__SCALAR && (defined(__GNUC__) || defined(__clang__)) && !defined(__TINYC__)
#define SFIELD__SIMD_X86 0
#define SFIELD__SIMD_VECTORS 1
#define SFIELD__SIMD_WIDTH 4
#else
#define SFIELD__SIMD_X86 0
#define SFIELD__SIMD_VECTORS 0
#define SFIELD__SIMD_WIDTH 1
#endif
#ifdef __has_include
#if !__has_include(SFIELD__FILE)
#undef SFIELD__SIMD_SETS
#define SFIELD__SIMD_SETS 0
#endif
#endif
#if SFIELD__SIMD_VECTORS && defined(__aarch64__) && !defined(SFIELD__NO_SIMD)
#include <arm_neon.h>
#elif SFIELD__SIMD_VECTORS && defined(__wasm_simd128__) && !defined(SFIELD__NO_SIMD)
#include <wasm_simd128.h>
#endif

#define SFIELD__NAME_OF_SET(name, set) name##_##set
#define SFIELD__NAME_IN_SET(name, set) SFIELD__NAME_OF_SET(name, set)
#define sfield__lanes SFIELD__NAME_IN_SET(sfield__lanes, SFIELD__SET)
#define sfield__lane_mask SFIELD__NAME_IN_SET(sfield__lane_mask, SFIELD__SET)
#define sfield__lane_ints SFIELD__NAME_IN_SET(sfield__lane_ints, SFIELD__SET)
#define sfield__piece SFIELD__NAME_IN_SET(sfield__piece, SFIELD__SET)
#define sfield__piece_ints SFIELD__NAME_IN_SET(sfield__piece_ints, SFIELD__SET)
#define sfield__piece_words SFIELD__NAME_IN_SET(sfield__piece_words, SFIELD__SET)
#define sfield__lanes_load SFIELD__NAME_IN_SET(sfield__lanes_load, SFIELD__SET)
#define sfield__lanes_store SFIELD__NAME_IN_SET(sfield__lanes_store, SFIELD__SET)
#define sfield__lanes_all SFIELD__NAME_IN_SET(sfield__lanes_all, SFIELD__SET)
#define sfield__lanes_add SFIELD__NAME_IN_SET(sfield__lanes_add, SFIELD__SET)
#define sfield__lanes_sub SFIELD__NAME_IN_SET(sfield__lanes_sub, SFIELD__SET)
#define sfield__lanes_mul SFIELD__NAME_IN_SET(sfield__lanes_mul, SFIELD__SET)
#define sfield__lanes_div SFIELD__NAME_IN_SET(sfield__lanes_div, SFIELD__SET)
#define sfield__lanes_muladd SFIELD__NAME_IN_SET(sfield__lanes_muladd, SFIELD__SET)
#define sfield__lanes_max SFIELD__NAME_IN_SET(sfield__lanes_max, SFIELD__SET)
#define sfield__lanes_min SFIELD__NAME_IN_SET(sfield__lanes_min, SFIELD__SET)
#define sfield__lanes_sqrt SFIELD__NAME_IN_SET(sfield__lanes_sqrt, SFIELD__SET)
#define sfield__lanes_abs SFIELD__NAME_IN_SET(sfield__lanes_abs, SFIELD__SET)
#define sfield__lanes_negate SFIELD__NAME_IN_SET(sfield__lanes_negate, SFIELD__SET)
#define sfield__lanes_greater SFIELD__NAME_IN_SET(sfield__lanes_greater, SFIELD__SET)
#define sfield__lanes_at_least SFIELD__NAME_IN_SET(sfield__lanes_at_least, SFIELD__SET)
#define sfield__lanes_differ SFIELD__NAME_IN_SET(sfield__lanes_differ, SFIELD__SET)
#define sfield__lanes_select SFIELD__NAME_IN_SET(sfield__lanes_select, SFIELD__SET)
#define sfield__lanes_keep SFIELD__NAME_IN_SET(sfield__lanes_keep, SFIELD__SET)
#define sfield__lanes_truncate SFIELD__NAME_IN_SET(sfield__lanes_truncate, SFIELD__SET)
#define sfield__lanes_of_ints SFIELD__NAME_IN_SET(sfield__lanes_of_ints, SFIELD__SET)
#define sfield__lanes_of_shorts SFIELD__NAME_IN_SET(sfield__lanes_of_shorts, SFIELD__SET)
#define sfield__lanes_gather SFIELD__NAME_IN_SET(sfield__lanes_gather, SFIELD__SET)
#define sfield__lanes3 SFIELD__NAME_IN_SET(sfield__lanes3, SFIELD__SET)
#define sfield__lanes3_load SFIELD__NAME_IN_SET(sfield__lanes3_load, SFIELD__SET)
#define sfield__lanes3_all SFIELD__NAME_IN_SET(sfield__lanes3_all, SFIELD__SET)
#define sfield__lanes3_scale SFIELD__NAME_IN_SET(sfield__lanes3_scale, SFIELD__SET)
#define sfield__lanes3_sub SFIELD__NAME_IN_SET(sfield__lanes3_sub, SFIELD__SET)
#define sfield__lanes3_dot SFIELD__NAME_IN_SET(sfield__lanes3_dot, SFIELD__SET)
#define sfield__mask_and SFIELD__NAME_IN_SET(sfield__mask_and, SFIELD__SET)
#define sfield__mask_or SFIELD__NAME_IN_SET(sfield__mask_or, SFIELD__SET)
#define sfield__mask_any SFIELD__NAME_IN_SET(sfield__mask_any, SFIELD__SET)
#define sfield__mask_bits SFIELD__NAME_IN_SET(sfield__mask_bits, SFIELD__SET)
#define sfield__mask_of_bits SFIELD__NAME_IN_SET(sfield__mask_of_bits, SFIELD__SET)
#define sfield__ints_load SFIELD__NAME_IN_SET(sfield__ints_load, SFIELD__SET)
#define sfield__ints_store SFIELD__NAME_IN_SET(sfield__ints_store, SFIELD__SET)
#define sfield__ints_all SFIELD__NAME_IN_SET(sfield__ints_all, SFIELD__SET)
#define sfield__ints_equal SFIELD__NAME_IN_SET(sfield__ints_equal, SFIELD__SET)

/* Returns 2 if AVX-512 may be used, 1 if AVX2 may be, otherwise 0. */
static inline int sfield__simd_level(void)
{
    if (!SFIELD__SIMD_SETS || !sfield__cpu_has_avx2()) return 0;
    return sfield__cpu_has_avx512() ? 2 : 1;
}

/* ==== src/shared/bits.h ==== */

/* unit bits: counting and finding bits */

/* Returns how many bits of x are set. */
static inline uint32_t sfield__popcount(uint64_t x)
{
    x -= x >> 1 & 0x5555555555555555u;
    x = (x & 0x3333333333333333u) + (x >> 2 & 0x3333333333333333u);
    x = (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    return (uint32_t)(x * 0x0101010101010101u >> 56);
}

/* ==== src/shared/part.h ==== */

/* unit part: the caller's progress within parts of a call, and whether it cancels */

/* The share from..to of a call's progress, 0..1. progress may be NULL. */
typedef struct sfield__part {
    int (*progress)(void *user, float fraction);
    void *user;
    float from, to;
} sfield__part;

/* Tells the caller that this fraction of the part is done. Returns not 0 if the caller cancels. progress
   must not be NULL. */
static inline int sfield__part_tell(const sfield__part *p, float fraction)
{
    return p->progress(p->user, p->from + (p->to - p->from) * fraction);
}

static inline sfield__part sfield__part_of(const sfield__part *whole, float from, float to)
{
    sfield__part p = *whole;
    p.from = whole->from + (whole->to - whole->from) * from;
    p.to = whole->from + (whole->to - whole->from) * to;
    return p;
}

/* Returns 1 if the caller cancels before step i of count; the caller is asked every so many steps. */
static inline int sfield__cancelled(const sfield__part *p, size_t i, size_t count, size_t every)
{
    return p->progress && i % every == 0 && sfield__part_tell(p, (float)((double)i / (double)count)) != 0;
}

/* ==== src/shared/prefetch.h ==== */

/* unit prefetch: asks for a cache line before it is read, in headers without unit hot, which does so, too */

#if defined(__GNUC__) && !defined(__TINYC__)
#define SFIELD__PREFETCH(p) __builtin_prefetch(p)
#else
#define SFIELD__PREFETCH(p) ((void)(p))
#endif

/* ==== src/shared/message.h ==== */

/* unit message: one line for the caller's log that says why a call failed */

/* SFIELD__COLD stands before functions that are needed only by calls that fail: compilers make these functions
   small, and take branches to them for unlikely. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define SFIELD__COLD __attribute__((cold))
#else
#define SFIELD__COLD
#endif

/* Where a message goes, and the name of the function that failed. If log is NULL, nothing is written. */
typedef struct sfield__logger {
    void (*log)(void *user, const char *message);
    void *user;
    const char *function;
} sfield__logger;

typedef struct sfield__message { char text[256]; size_t used; } sfield__message;

/* Appends a text; what does not fit is cut off. */
static inline SFIELD__COLD void sfield__message_text(sfield__message *m, const char *s)
{
    while (*s && m->used + 1 < sizeof m->text) m->text[m->used++] = *s++;
    m->text[m->used] = 0;
}

static inline SFIELD__COLD void sfield__message_count(sfield__message *m, uint64_t value)
{
    char digits[24];
    size_t at = sizeof digits - 1;
    digits[at] = 0;
    do digits[--at] = (char)('0' + (int)(value % 10));
    while ((value /= 10) != 0);
    sfield__message_text(m, digits + at);
}

/* Writes six significant digits without the zeros at their end. Returns how many digits are left and writes
   *exponent, the power of ten of the first one. value is finite and above 0. */
static inline SFIELD__COLD int sfield__message_digits(double value, char digits[8], int *exponent)
{
    uint32_t whole;
    int count = 6, i;

    for (*exponent = 5; value >= 999999.5; value /= 10.0) ++*exponent;
    for (; value < 99999.95; value *= 10.0) --*exponent;
    whole = (uint32_t)(value + 0.5);
    if (whole > 999999) {
        whole = 100000;
        ++*exponent;
    }
    for (; count > 1 && whole % 10 == 0; count--) whole /= 10;
    for (i = count; i > 0; whole /= 10) digits[--i] = (char)('0' + (int)(whole % 10));
    digits[count] = 0;
    return count;
}

/* Appends a number, in the same way in every locale: whole numbers below 2^53 with all their digits, others
   with six, as in 0.25, -3, 1.5e-7. */
static inline SFIELD__COLD void sfield__message_number(sfield__message *m, double value)
{
    char digits[8], first[2] = { 0, 0 };
    int exponent, count, i;

    if (value != value) {
        sfield__message_text(m, "not a number");
        return;
    }
    if (value < 0.0) sfield__message_text(m, "-");
    if (value < 0.0) value = -value;
    if (!(value > 0.0) || value > 1.7976931348623157e308) {
        sfield__message_text(m, value > 0.0 ? "infinity" : "0");
        return;
    }
    if (value < 9007199254740992.0 && value - (double)(uint64_t)value <= 0.0) {
        sfield__message_count(m, (uint64_t)value);
        return;
    }
    count = sfield__message_digits(value, digits, &exponent);
    first[0] = digits[0];
    if (exponent < -4 || exponent > 9) {
        sfield__message_text(m, first);
        if (count > 1) sfield__message_text(m, ".");
        sfield__message_text(m, digits + 1);
        sfield__message_text(m, exponent < 0 ? "e-" : "e");
        sfield__message_count(m, (uint64_t)(exponent < 0 ? -exponent : exponent));
        return;
    }
    if (exponent < 0) sfield__message_text(m, "0.");
    for (i = exponent; i < -1; i++) sfield__message_text(m, "0");
    for (i = 0; i < count; i++) {
        if (exponent >= 0 && i == exponent + 1) sfield__message_text(m, ".");
        first[0] = digits[i];
        sfield__message_text(m, first);
    }
    for (i = count; i <= exponent; i++) sfield__message_text(m, "0");
}

/* Begins a line: "FUNCTION: FIELD". */
static inline SFIELD__COLD void sfield__message_begin(sfield__message *m,
                                          const sfield__logger *logger, const char *field)
{
    m->used = 0;
    sfield__message_text(m, logger->function);
    sfield__message_text(m, ": ");
    sfield__message_text(m, field);
}

/* Logs "FUNCTION: FIELD TEXT", as in "cohsm_build: mesh.positions is NULL". */
static inline SFIELD__COLD void sfield__log_text(const sfield__logger *logger, const char *field, const char *text)
{
    sfield__message m;
    if (!logger->log) return;
    sfield__message_begin(&m, logger, field);
    sfield__message_text(&m, " ");
    sfield__message_text(&m, text);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: FIELD is VALUE; it must be WANTED", as in "cohsm_build: desc.map_side is 3; it must be 0 or
   4..1024". */
static inline SFIELD__COLD void sfield__log_value(const sfield__logger *logger, const char *field, double value,
                                      const char *wanted)
{
    sfield__message m;
    if (!logger->log) return;
    sfield__message_begin(&m, logger, field);
    sfield__message_text(&m, " is ");
    sfield__message_number(&m, value);
    sfield__message_text(&m, "; it must be ");
    sfield__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: ARRAY[INDEX] WHAT VALUE; it must be WANTED", as in "rsm_gather: normals[17] has the length
   0.5; it must be 1 (0.97..1.03), or 0". */
static inline SFIELD__COLD void sfield__log_element(const sfield__logger *logger, const char *array, uint64_t index,
                                        const char *what, double value, const char *wanted)
{
    sfield__message m;
    if (!logger->log) return;
    sfield__message_begin(&m, logger, array);
    sfield__message_text(&m, "[");
    sfield__message_count(&m, index);
    sfield__message_text(&m, "] ");
    sfield__message_text(&m, what);
    sfield__message_text(&m, " ");
    sfield__message_number(&m, value);
    sfield__message_text(&m, "; it must be ");
    sfield__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: mesh: index 2 of triangle 17 is 90, but the mesh has 80 vertices". position counts the
   indices from 0. */
static inline SFIELD__COLD void sfield__log_index(const sfield__logger *logger, const char *mesh,
                                      uint64_t position, uint64_t index, uint64_t vertex_count)
{
    sfield__message m;
    if (!logger->log) return;
    sfield__message_begin(&m, logger, mesh);
    sfield__message_text(&m, ": index ");
    sfield__message_count(&m, position % 3);
    sfield__message_text(&m, " of triangle ");
    sfield__message_count(&m, position / 3);
    sfield__message_text(&m, " is ");
    sfield__message_count(&m, index);
    sfield__message_text(&m, ", but the mesh has ");
    sfield__message_count(&m, vertex_count);
    sfield__message_text(&m, vertex_count == 1 ? " vertex" : " vertices");
    logger->log(logger->user, m.text);
}

/* ==== src/shared/mask.h ==== */

/* unit mask: holes of alpha masks, asked for at the samples of rasters */

/* Writes the weights of a triangle's corners where the ray through x, y meets the triangle. c holds x, y and
   w of each corner as the view has them; w is the depth in units of the view's half width, and 1 where rays
   are parallel. A sample that rounding puts beyond an edge is moved onto the edge. */
static inline void sfield__mask_weights(const double *c, double x, double y, float weights[3])
{
    double e[3], sum, sign;
    int k;
    for (k = 0; k < 3; k++) {
        const double *a = c + 3 * ((k + 1) % 3), *b = c + 3 * ((k + 2) % 3);
        e[k] = x * (a[1] * b[2] - a[2] * b[1]) + y * (a[2] * b[0] - a[0] * b[2]);
        e[k] += a[0] * b[1] - a[1] * b[0];
    }
    sign = e[0] + e[1] + e[2] < 0.0 ? -1.0 : 1.0;
    for (k = 0, sum = 0.0; k < 3; k++) {
        e[k] = sign * e[k] > 0.0 ? sign * e[k] : 0.0;
        sum += e[k];
    }
    for (k = 0; k < 3; k++) weights[k] = sum > 0.0 ? (float)(e[k] / sum) : 1.0f / 3.0f;
}

/* ==== src/shadowfield/services.h ==== */

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

/* ==== src/shadowfield/sh_basis.h ==== */

/* ---- harmonics: the basis, quadrature over the sphere, windows ---- */

static const double sfield__pi = 3.14159265358979323846;

/* Computes sine and cosine in double, with the same bits everywhere, for |x| <= 2 pi. Taylor series on |r| <=
   pi / 4 are exact to the last bits. */
static void sfield__sincos_d(double x, double *s, double *c)
{
    int k = (int)(x / (0.5 * sfield__pi) + (x < 0 ? -0.5 : 0.5)), i;
    double r = x - (double)k * (0.5 * sfield__pi), z = r * r, sine = 0, cosine = 0;
    for (i = 10; i >= 1; i--) {
        sine = (1 + sine) * -z / (double)(2 * i * (2 * i + 1));
        cosine = (1 + cosine) * -z / (double)(2 * i * (2 * i - 1));
    }
    sine = r * (1 + sine);
    cosine = 1 + cosine;
    *s = k & 1 ? cosine : sine;
    *c = k & 1 ? sine : cosine;
    if (k & 2) *s = -*s;
    if ((k + 1) & 2) *c = -*c;
}

/* The recurrences are those of normalised associated Legendre functions without their power of sin(theta).
   That power goes with the cosine and sine of m phi into the polynomials cm + i sm = (x + i y)^m. There is no
   sign of Condon and Shortley. */
SFIELD_DEF void sfield_sh_basis(uint32_t bands, const double direction[3], double *y)
{
    double z = direction[2], cm = 1, sm = 0;
    double older, diagonal = 0.28209479177387814347;
    uint32_t l, m;
    for (m = 0; m < bands; m++) {
        double now = diagonal, two = m ? 1.41421356237309504880 : 1;
        older = 0;
        for (l = m; l < bands; l++) {
            double a, next;
            y[l * l + l + m] = two * now * cm;
            if (m) y[l * l + l - m] = two * now * sm;
            a = sqrt((4.0 * (l + 1) * (l + 1) - 1) / ((double)(l + 1) * (l + 1) - (double)m * m));
            next = a * z * now;
            if (l > m)
                next -= older * a * sqrt(((double)l * l - (double)m * m) / (4.0 * l * l - 1));
            older = now;
            now = next;
        }
        diagonal *= sqrt((2.0 * m + 3) / (2.0 * m + 2));
        older = cm;
        cm = cm * direction[0] - sm * direction[1];
        sm = older * direction[1] + sm * direction[0];
    }
}

static size_t sfield__grid_size(uint32_t degree) { return (size_t)(degree / 2 + 1) * (degree + 1); }

/* Writes x, y, z and weight of the nodes of a grid: Gauss-Legendre in z times equal steps in phi. Sums over
   the grid are exact for polynomials up to the degree. */
static void sfield__fill_grid(uint32_t degree, double *node)
{
    uint32_t n = degree / 2 + 1, m = degree + 1, i;
    uint32_t j, step;
    for (i = 0; i < n; i++) {
        double z, unused, slope = 1, radius;
        sfield__sincos_d(sfield__pi * (i + 0.75) / (n + 0.5), &unused, &z);
        for (step = 0; step < 8; step++) {
            double p0 = 1, p1 = z, p;
            for (j = 2; j <= n; j++) {
                p = ((2.0 * j - 1) * z * p1 - (j - 1.0) * p0) / j;
                p0 = p1;
                p1 = p;
            }
            slope = n * (p0 - z * p1) / (1 - z * z);
            z -= p1 / slope;
        }
        radius = sqrt(1 - z * z);
        for (j = 0; j < m; j++) {
            double s, c;
            sfield__sincos_d(2 * sfield__pi * j / m, &s, &c);
            node[0] = radius * c;
            node[1] = radius * s;
            node[2] = z;
            node[3] = 2 / ((1 - z * z) * slope * slope) * 2 * sfield__pi / m;
            node += 4;
        }
    }
}

static void sfield__evaluate_basis(const double *node, size_t nodes, uint32_t bands, double *basis)
{
    size_t g;
    for (g = 0; g < nodes; g++) sfield_sh_basis(bands, node + 4 * g, basis + g * bands * bands);
}

SFIELD_DEF void sfield_sh_window(uint32_t bands, float strength, float factors[SFIELD_MAX_BANDS])
{
    uint32_t l;
    for (l = 0; l < bands && l < SFIELD_MAX_BANDS; l++)
        factors[l] = 1.0f / (1.0f + strength * (float)(l * l * (l + 1) * (l + 1)));
}

/* Returns whether a function, its bands multiplied by factors, is at least `lowest` in 36 x 72 directions. */
static int sfield__is_above(uint32_t bands, const float *factors, const float *coefs, float lowest)
{
    uint32_t i, k, l;
    for (i = 0; i < 36 * 72; i++) {
        double d[3], y[SFIELD_MAX_COEFS], value = 0;
        double s, c, ring;
        sfield__sincos_d(sfield__pi * (i / 72) / 35, &ring, &d[2]);
        sfield__sincos_d(sfield__pi * (i % 72) / 36, &s, &c);
        d[0] = ring * c;
        d[1] = ring * s;
        sfield_sh_basis(bands, d, y);
        for (l = 0, k = 0; l < bands; l++)
            for (; k < (l + 1) * (l + 1); k++) value += (double)(factors[l] * coefs[k]) * y[k];
        if (!(value >= (double)lowest)) return 0;
    }
    return 1;
}

SFIELD_DEF float sfield_sh_window_fit(uint32_t bands, const float *coefs, float lowest)
{
    float factors[SFIELD_MAX_BANDS], low = 0, high = 1, strength = 0;
    uint32_t step;
    if (!coefs || bands < 1 || bands > SFIELD_MAX_BANDS) return 0;
    for (step = 0; step < 20; step++) {         /* the first try is no window at all */
        sfield_sh_window(bands, strength, factors);
        if (!sfield__is_above(bands, factors, coefs, lowest)) low = strength;
        else if (strength == 0) return 0;
        else high = strength;
        strength = 0.5f * (low + high);
    }
    return high;
}

SFIELD_DEF void sfield_sh_cosine(uint32_t bands, float factors[SFIELD_MAX_BANDS])
{
    double binomial = 1;                        /* l! / (2^l (l/2)!^2) */
    uint32_t l;
    for (l = 0; l < bands && l < SFIELD_MAX_BANDS; l++) {
        if (l & 1) factors[l] = l == 1 ? (float)(2 * sfield__pi / 3) : 0.0f;
        else {
            if (l) binomial *= (l - 1.0) / l;
            factors[l] = (float)(2 * sfield__pi * (l % 4 == 0 ? -1 : 1) / ((l + 2.0) * (l - 1.0)) * binomial);
        }
    }
}

/* ==== src/shadowfield/sh_algebra.h ==== */

/* ---- harmonics: products of sixteen pairs of vectors ---- */

typedef struct sfield__entry { uint32_t pair; float c; } sfield__entry;

struct sfield_algebra {
    sfield__allocator allocator;
    sfield__logger log;             /* of the system that the tables were made with */
    uint32_t       bands, coefs;    /* n, n^2 */
    int            simd;            /* 0 none, 1 AVX2, 2 AVX-512 */
    uint32_t       pair_count;      /* of i >= j >= 1 with any tripling coefficient */
    uint32_t       row[SFIELD_MAX_COEFS + 1];     /* first pair with this i */
    uint32_t       first[SFIELD_MAX_COEFS + 1];   /* first entry of output k */
    uint8_t       *pair;            /* j of each pair; i is its row */
    uint8_t       *pair_i;
    sfield__entry *entry;
    uint32_t       node_count;      /* quadrature of degree 2 (n - 1) for rotations */
    double        *node;            /* x, y, z, weight */
    double        *basis;           /* n^2 at each node, times weight */
    void          *memory;
};

static const float sfield__y00 = 0.282094792f;      /* Y_00, and C_0jj for every j */

/* ---- harmonics: tripling coefficients, and products of any number of vectors ---- */

static int sfield__may_triple(uint32_t i, uint32_t j, uint32_t k)
{
    uint32_t a = 0, b = 0, c = 0;
    while ((a + 1) * (a + 1) <= i) a++;
    while ((b + 1) * (b + 1) <= j) b++;
    while ((c + 1) * (c + 1) <= k) c++;
    return (a + b + c) % 2 == 0 && a + b >= c && a + c >= b && b + c >= a;
}

/* Finds the pairs by nodes of degree 3 (n - 1); table: coefs floats a pair. Returns how many are not 0. */
static uint32_t sfield__find_tripling(sfield_algebra *t, const double *basis, const double *node,
                                      size_t nodes, double *product, float *table)
{
    uint32_t i, j, k, entries = 0;
    size_t g;
    t->pair_count = 0;
    for (i = 1; i < t->coefs; i++) {
        t->row[i] = t->pair_count;
        for (j = 1; j <= i; j++) {
            float *c = table + (size_t)t->pair_count * t->coefs;
            uint32_t used = 0;
            for (g = 0; g < nodes; g++)
                product[g] = node[4 * g + 3] * basis[g * t->coefs + i] * basis[g * t->coefs + j];
            for (k = 1; k < t->coefs; k++) {
                double sum = 0;
                for (g = 0; sfield__may_triple(i, j, k) && g < nodes; g++)
                    sum += product[g] * basis[g * t->coefs + k];
                c[k] = fabs(sum) > 1e-9 ? (float)sum : 0.0f;
                used += c[k] != 0.0f;
            }
            if (!used) continue;
            entries += used;
            t->pair[t->pair_count] = (uint8_t)j;
            t->pair_i[t->pair_count++] = (uint8_t)i;
        }
    }
    t->row[t->coefs] = t->pair_count;
    return entries;
}

static void sfield__fill_entries(sfield_algebra *t, const float *table)
{
    uint32_t k, q, n = 0;
    for (k = 1; k < t->coefs; k++) {
        t->first[k] = n;
        for (q = 0; q < t->pair_count; q++)
            if (table[(size_t)q * t->coefs + k] != 0.0f) {
                t->entry[n].pair = q;
                t->entry[n++].c = table[(size_t)q * t->coefs + k];
            }
    }
    t->first[t->coefs] = n;
}

static sfield_result sfield__fill_algebra(sfield_algebra *t, double *work, size_t nodes)
{
    uint32_t pairs = t->coefs * (t->coefs - 1) / 2, entries;
    double *node = work, *basis = node + 4 * nodes, *product = basis + nodes * t->coefs;
    float *table = (float *)(void *)(product + nodes);
    size_t g, k;
    uint8_t *at;
    sfield__fill_grid(3 * (t->bands - 1), node);
    sfield__evaluate_basis(node, nodes, t->bands, basis);
    t->pair = (uint8_t *)(table + (size_t)pairs * t->coefs);
    t->pair_i = t->pair + pairs;
    entries = sfield__find_tripling(t, basis, node, nodes, product, table);
    t->node_count = (uint32_t)sfield__grid_size(2 * (t->bands - 1));
    at = (uint8_t *)sfield__alloc(&t->allocator, t->node_count * (4 + t->coefs) * sizeof(double) +
                                                     entries * sizeof *t->entry + 2 * t->pair_count + 16);
    if (!at) return SFIELD_ERR_ALLOC;
    t->memory = at;
    t->node = (double *)(void *)at;
    t->basis = t->node + 4 * (size_t)t->node_count;
    t->entry = (sfield__entry *)(void *)(t->basis + (size_t)t->node_count * t->coefs);
    at = (uint8_t *)(t->entry + entries);
    memcpy(at, t->pair, t->pair_count);
    memcpy(at + t->pair_count, t->pair_i, t->pair_count);
    t->pair = at;
    t->pair_i = at + t->pair_count;
    sfield__fill_entries(t, table);
    sfield__fill_grid(2 * (t->bands - 1), t->node);
    sfield__evaluate_basis(t->node, t->node_count, t->bands, t->basis);
    for (g = 0; g < t->node_count; g++)
        for (k = 0; k < t->coefs; k++) t->basis[g * t->coefs + k] *= t->node[4 * g + 3];
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_algebra_create(uint32_t bands, const sfield_system *system,
                                               sfield_algebra **out)
{
    const sfield__logger log = sfield__logger_of(system, "sfield_algebra_create");
    sfield__allocator a = sfield__allocator_of(system);
    sfield_algebra *t;
    sfield_result result;
    double *work;
    size_t nodes, pairs;
    if (!out) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "out", "is NULL");
    if (!sfield__check_value(&log, bands >= 1 && bands <= SFIELD_MAX_BANDS, "bands", bands, "1..8"))
        return SFIELD_ERR_ARGUMENT;
    if (!sfield__system_good(system)) return sfield__fail_allocator(&log);
    t = (sfield_algebra *)sfield__alloc(&a, sizeof *t);
    if (!t) return SFIELD_ERR_ALLOC;
    memset(t, 0, sizeof *t);
    t->allocator = a;
    t->log = log;
    t->bands = bands;
    t->coefs = bands * bands;
    t->simd = sfield__simd_level();
    nodes = sfield__grid_size(3 * (bands - 1));
    pairs = (size_t)t->coefs * (t->coefs - 1) / 2;
    work = (double *)sfield__alloc(&a, nodes * (t->coefs + 5) * sizeof *work +
                                           pairs * (t->coefs * sizeof(float) + 2));
    result = work ? sfield__fill_algebra(t, work, nodes) : SFIELD_ERR_ALLOC;
    sfield__free(&a, work);
    if (result != SFIELD_OK) {
        sfield_algebra_free(t);
        return result;
    }
    *out = t;
    return SFIELD_OK;
}

SFIELD_DEF void sfield_algebra_free(sfield_algebra *algebra)
{
    sfield__allocator a;
    if (!algebra) return;
    a = algebra->allocator;
    sfield__free(&a, algebra->memory);
    sfield__free(&a, algebra);
}

/* Copies planes of `count` vectors, fewer than 16, to a tile. Missing lanes are 0. */
static void sfield__load_tile(uint32_t coefs, size_t count, const float *in, size_t stride, float *tile)
{
    size_t k, i;
    for (k = 0; k < coefs; k++)
        for (i = 0; i < SFIELD__LANES; i++)
            tile[k * SFIELD__LANES + i] = i < count ? in[k * stride + i] : 0.0f;
}

static void sfield__store_tile(uint32_t coefs, size_t count, const float *tile, float *out, size_t stride)
{
    size_t k, i;
    for (k = 0; k < coefs; k++)
        for (i = 0; i < count; i++) out[k * stride + i] = tile[k * SFIELD__LANES + i];
}

SFIELD_DEF sfield_result sfield_sh_product(const sfield_algebra *t, size_t count, const float *a,
                                           const float *b, float *out, size_t stride)
{
    float tile[2][SFIELD_MAX_COEFS * SFIELD__LANES] = { { 0 } };
    sfield__logger log;
    size_t i;
    if (!t) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_for(&t->log, "sfield_sh_product");
    if (!a || !b || !out) return sfield__fail_null(&log, !a ? "a" : !b ? "b" : "out");
    if (!sfield__check_stride(&log, stride, count)) return SFIELD_ERR_ARGUMENT;
    for (i = 0; i + SFIELD__LANES <= count; i += SFIELD__LANES)
        sfield__product16(t, a + i, b + i, out + i, stride, 0);
    if (i == count) return SFIELD_OK;
    sfield__load_tile(t->coefs, count - i, a + i, stride, tile[0]);
    sfield__load_tile(t->coefs, count - i, b + i, stride, tile[1]);
    sfield__product16(t, tile[0], tile[1], tile[0], SFIELD__LANES, 0);
    sfield__store_tile(t->coefs, count - i, tile[0], out + i, stride);
    return SFIELD_OK;
}

SFIELD_DEF size_t sfield_sh_terms(const sfield_algebra *t, uint32_t *terms, float *factors)
{
    uint32_t k, q;
    if (!t) return 0;
    for (k = 1; k < t->coefs && terms && factors; k++)
        for (q = t->first[k]; q < t->first[k + 1]; q++) {
            uint32_t pair = t->entry[q].pair;
            terms[q] = (uint32_t)t->pair_i[pair] | (uint32_t)t->pair[pair] << 8 | k << 16;
            factors[q] = t->entry[q].c;
        }
    return t->first[t->coefs];
}

SFIELD_DEF sfield_result sfield_sh_dot(uint32_t bands, size_t count, const float *a, const float *b,
                                       float *out, size_t stride)
{
    size_t i, j, n, k;
    if (bands < 1 || bands > SFIELD_MAX_BANDS || !a || !b || !out || stride < count)
        return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < count; i += n) {
        float sum[SFIELD__LANES] = { 0 };
        n = count - i < SFIELD__LANES ? count - i : (size_t)SFIELD__LANES;
        for (k = 0; k < (size_t)bands * bands; k++) {
            const float *p = a + k * stride + i, *q = b + k * stride + i;
            if (n == SFIELD__LANES)
                for (j = 0; j < SFIELD__LANES; j++) sum[j] += p[j] * q[j];
            else
                for (j = 0; j < n; j++) sum[j] += p[j] * q[j];
        }
        for (j = 0; j < n; j++) out[i + j] = sum[j];
    }
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_sh_product_n(uint32_t bands, uint32_t functions, const float *coefs,
                                             const sfield_system *system, double *out)
{
    const sfield__logger log = sfield__logger_of(system, "sfield_sh_product_n");
    sfield__allocator a = sfield__allocator_of(system);
    double y[SFIELD_MAX_COEFS], sum[SFIELD_MAX_COEFS], *node;
    uint32_t n = bands * bands, f, k;
    size_t nodes, g;
    if (!coefs || !out) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, coefs ? "out" : "coefs", "is NULL");
    if (!sfield__check_value(&log, bands >= 1 && bands <= SFIELD_MAX_BANDS, "bands", bands, "1..8") ||
        !sfield__check_value(&log, functions >= 1 && functions <= 32, "functions", functions, "1..32"))
        return SFIELD_ERR_ARGUMENT;
    if (!sfield__system_good(system)) return sfield__fail_allocator(&log);
    nodes = sfield__grid_size((functions + 1) * (bands - 1));
    node = (double *)sfield__alloc_array(&a, nodes, 4 * sizeof *node);
    if (!node) return SFIELD_ERR_ALLOC;
    sfield__fill_grid((functions + 1) * (bands - 1), node);
    memset(sum, 0, sizeof sum);
    for (g = 0; g < nodes; g++) {
        double product = node[4 * g + 3];
        sfield_sh_basis(bands, node + 4 * g, y);
        for (f = 0; f < functions; f++) {
            double value = 0;
            for (k = 0; k < n; k++) value += (double)coefs[f * n + k] * y[k];
            product *= value;
        }
        for (k = 0; k < n; k++) sum[k] += product * y[k];
    }
    sfield__free(&a, node);
    memcpy(out, sum, n * sizeof *out);
    return SFIELD_OK;
}

/* ==== src/shadowfield/sh_rotations.h ==== */

/* ---- harmonics: rotations ---- */

/* Returns whether a matrix that rotates and scales does not rotate. Only the zeros are looked at, since a
   diagonal that was divided by its mean length may miss 1. */
static int sfield__is_upright(const float *m)
{
    return m[1] == 0 && m[2] == 0 && m[4] == 0 && m[6] == 0 && m[8] == 0 && m[9] == 0 && m[0] > 0 && m[5] > 0;
}

SFIELD_DEF sfield_result sfield_sh_rotation(const sfield_algebra *t, const float matrix[16],
                                            sfield_rotation *out)
{
    double sum[680], y[SFIELD_MAX_COEFS], *s;
    const double *basis;
    float scale, *block;
    uint32_t g, l, i, j;
    sfield__logger log;
    if (!t) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_for(&t->log, "sfield_sh_rotation");
    if (!matrix || !out) return sfield__fail_null(&log, matrix ? "out" : "matrix");
    if (!sfield__m4_is_rigid_uniform(matrix, &scale))
        return sfield__fail(&log, SFIELD_ERR_INPUT, "matrix", "is no rotation with one scale > 0");
    memset(sum, 0, sizeof sum);
    for (g = 0; g < t->node_count; g++) {
        const double *d = t->node + 4 * (size_t)g;
        double back[3], length;
        for (i = 0; i < 3; i++)
            back[i] = (double)matrix[4 * i] * d[0] + (double)matrix[4 * i + 1] * d[1] +
                      (double)matrix[4 * i + 2] * d[2];
        length = sqrt(back[0] * back[0] + back[1] * back[1] + back[2] * back[2]);
        for (i = 0; i < 3; i++) back[i] /= length;
        sfield_sh_basis(t->bands, back, y);
        for (l = 0, s = sum; l < t->bands; l++) {
            basis = t->basis + (size_t)g * t->coefs + l * l;
            for (i = 0; i < 2 * l + 1; i++)
                for (j = 0; j < 2 * l + 1; j++) *s++ += basis[i] * y[l * l + j];
        }
    }
    memset(out, 0, sizeof *out);
    out->bands = t->bands;
    out->identity = sfield__is_upright(matrix);
    for (l = 0, s = sum, block = out->block; l < t->bands; l++)
        for (i = 0; i < 2 * l + 1; i++)
            for (j = 0; j < 2 * l + 1; j++, s++)
                *block++ = out->identity ? (i == j ? 1.0f : 0.0f) : (float)*s;
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_sh_rotate(const sfield_rotation *r, size_t count, const float *in, float *out,
                                          size_t stride)
{
    float tile[SFIELD_MAX_COEFS * SFIELD__LANES] = { 0 };
    int simd = sfield__simd_level();
    uint32_t coefs;
    size_t i;
    if (!r || !in || !out || stride < count || r->bands < 1 || r->bands > SFIELD_MAX_BANDS)
        return SFIELD_ERR_ARGUMENT;
    coefs = r->bands * r->bands;
    for (i = 0; i + SFIELD__LANES <= count; i += SFIELD__LANES)
        sfield__rotate16(r, in + i, out + i, stride, 0, simd);
    if (i == count) return SFIELD_OK;
    sfield__load_tile(coefs, count - i, in + i, stride, tile);
    sfield__rotate16(r, tile, tile, SFIELD__LANES, 0, simd);
    sfield__store_tile(coefs, count - i, tile, out + i, stride);
    return SFIELD_OK;
}

/* ==== src/shadowfield/sh_logarithms.h ==== */

/* ---- harmonics: logarithms (Ren et al., "Real-time soft shadows in dynamic scenes using spherical harmonic
   exponentiation", SIGGRAPH 2006) ---- */

/* Does one Jacobi rotation of the symmetric matrix m and of the vectors v, n x n each. */
static void sfield__jacobi(double *m, double *v, uint32_t n, uint32_t p, uint32_t q)
{
    double off = m[p * n + q], theta, t;
    double c, s;
    uint32_t i;
    if (fabs(off) < 1e-15) return;
    theta = (m[q * n + q] - m[p * n + p]) / (2 * off);
    t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
    c = 1 / sqrt(t * t + 1);
    s = t * c;
    for (i = 0; i < n; i++) {
        double a = m[i * n + p], b = m[i * n + q];
        m[i * n + p] = c * a - s * b;
        m[i * n + q] = s * a + c * b;
    }
    for (i = 0; i < n; i++) {
        double a = m[p * n + i], b = m[q * n + i];
        m[p * n + i] = c * a - s * b;
        m[q * n + i] = s * a + c * b;
        a = v[p * n + i];
        b = v[q * n + i];
        v[p * n + i] = c * a - s * b;
        v[q * n + i] = s * a + c * b;
    }
}

/* Computes the logarithm log f = V^T log(D) V 1, where V^T D V is the matrix that multiplies by f. work has
   room for 2 n^2 doubles, where n is the number of coefficients. */
static void sfield__sh_log(const sfield_algebra *t, const float *f, float *out, double *work)
{
    uint32_t n = t->coefs, i, j;
    uint32_t k, q, sweep;
    double *m = work, *v = work + n * n, sum[SFIELD_MAX_COEFS];
    for (i = 0; i < n; i++)
        for (j = 0; j < n; j++) {
            m[i * n + j] = i == j ? (double)f[0] * (double)sfield__y00 : 0;
            v[i * n + j] = i == j;
        }
    for (j = 1; j < n; j++) m[j] = m[j * n] = (double)f[j] * (double)sfield__y00;
    for (k = 1; k < n; k++)
        for (q = t->first[k]; q < t->first[k + 1]; q++) {
            i = t->pair_i[t->entry[q].pair];
            j = t->pair[t->entry[q].pair];
            m[i * n + j] += (double)t->entry[q].c * (double)f[k];
            if (i != j) m[j * n + i] += (double)t->entry[q].c * (double)f[k];
        }
    for (sweep = 0; sweep < 10; sweep++)
        for (i = 0; i + 1 < n; i++)
            for (j = i + 1; j < n; j++) sfield__jacobi(m, v, n, i, j);
    memset(sum, 0, sizeof sum);
    for (i = 0; i < n; i++) {
        double d = m[i * n + i];
        d = (double)sfield__log((float)(d > 0.02 ? d : 0.02)) * v[i * n] / (double)sfield__y00;
        for (j = 0; j < n; j++) sum[j] += d * v[i * n + j];
    }
    for (j = 0; j < n; j++) out[j] = (float)sum[j];
}

SFIELD_DEF sfield_result sfield_sh_log(const sfield_algebra *t, const float *visibility, float *out)
{
    sfield__logger log;
    double *work;
    if (!t) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_for(&t->log, "sfield_sh_log");
    if (!visibility || !out) return sfield__fail_null(&log, visibility ? "out" : "visibility");
    work = (double *)sfield__alloc_array(&t->allocator, 2 * (size_t)t->coefs * t->coefs, sizeof *work);
    if (!work) return SFIELD_ERR_ALLOC;
    sfield__sh_log(t, visibility, out, work);
    sfield__free(&t->allocator, work);
    return SFIELD_OK;
}

/* Computes the exponentials of a tile. The constant is taken apart; of the rest h, exp(h) = (1 + h/s +
   (h/s)^2/2 + (h/s)^3/6)^s, where the power of two s is so large that |h/s| is small. out may be in. */
static void sfield__exponentiate16(const sfield_algebra *t, const float *in, float *out)
{
    float h[SFIELD_MAX_COEFS * SFIELD__LANES] = { 0 }, constant[SFIELD__LANES], most = 0, scale = 1;
    uint32_t k, i, squares, n = t->coefs * SFIELD__LANES;
    for (i = 0; i < SFIELD__LANES; i++) {
        float norm = 0;
        for (k = 1; k < t->coefs; k++) norm += in[k * SFIELD__LANES + i] * in[k * SFIELD__LANES + i];
        most = norm > most ? norm : most;
        constant[i] = sfield__exp(in[i] * sfield__y00);
    }
    for (squares = 0; squares < 12 && most * scale * scale > 0.25f; squares++) scale *= 0.5f;
    for (k = 0; k < n; k++) h[k] = k < SFIELD__LANES ? 0.0f : in[k] * scale;
    for (k = 0; k < n; k++) out[k] = h[k] * (1.0f / 3) + (k < SFIELD__LANES ? 1 / sfield__y00 : 0.0f);
    for (i = 2; i > 0; i--) {                   /* Horner: 1 + h (1 + h/2 (1 + h/3)) */
        sfield__product16(t, out, h, out, SFIELD__LANES, 0);
        for (k = 0; k < n; k++) out[k] = out[k] / (float)i + (k < SFIELD__LANES ? 1 / sfield__y00 : 0.0f);
    }
    for (i = 0; i < squares; i++) sfield__product16(t, out, out, out, SFIELD__LANES, 0);
    for (k = 0; k < n; k++) out[k] *= constant[k % SFIELD__LANES];
}

SFIELD_DEF sfield_result sfield_sh_exp(const sfield_algebra *t, size_t count, const float *in, float *out,
                                       size_t stride)
{
    float tile[SFIELD_MAX_COEFS * SFIELD__LANES] = { 0 };
    sfield__logger log;
    size_t i, n;
    if (!t) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_for(&t->log, "sfield_sh_exp");
    if (!in || !out) return sfield__fail_null(&log, in ? "out" : "in");
    if (!sfield__check_stride(&log, stride, count)) return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < count; i += n) {
        n = count - i < SFIELD__LANES ? count - i : (size_t)SFIELD__LANES;
        sfield__load_tile(t->coefs, n, in + i, stride, tile);
        sfield__exponentiate16(t, tile, tile);
        sfield__store_tile(t->coefs, n, tile, out + i, stride);
    }
    return SFIELD_OK;
}

/* ==== src/shadowfield/cubes.h ==== */

/* ---- cubes: texels of cube maps, and their harmonics ---- */

/* Writes a direction's components along a face's s, its t and its axis. Faces are in OpenGL's order. */
SFIELD__INLINE void sfield__to_face(uint32_t face, const float *p, float *q)
{
    float x = p[0], y = p[1], z = p[2];
    switch (face) {
    case 0: q[0] = -z, q[1] = -y, q[2] = x; break;
    case 1: q[0] = z, q[1] = -y, q[2] = -x; break;
    case 2: q[0] = x, q[1] = z, q[2] = y; break;
    case 3: q[0] = x, q[1] = -z, q[2] = -y; break;
    case 4: q[0] = x, q[1] = -y, q[2] = z; break;
    default: q[0] = -x, q[1] = -y, q[2] = -z; break;
    }
}

SFIELD__INLINE void sfield__from_face(uint32_t face, double s, double t, double d[3])
{
    switch (face) {
    case 0: d[0] = 1, d[1] = -t, d[2] = -s; break;
    case 1: d[0] = -1, d[1] = -t, d[2] = s; break;
    case 2: d[0] = s, d[1] = 1, d[2] = t; break;
    case 3: d[0] = s, d[1] = -1, d[2] = -t; break;
    case 4: d[0] = s, d[1] = -t, d[2] = 1; break;
    default: d[0] = -s, d[1] = -t, d[2] = -1; break;
    }
}

static uint32_t sfield__face_of(const float *p)
{
    float x = fabsf(p[0]), y = fabsf(p[1]), z = fabsf(p[2]);
    if (x >= y && x >= z) return p[0] > 0 ? 0u : 1u;
    if (y >= z) return p[1] > 0 ? 2u : 3u;
    return p[2] > 0 ? 4u : 5u;
}

static uint32_t sfield__spread_bits(uint32_t x)         /* 6 bits, a zero between each two */
{
    x = (x | x << 4) & 0x30fu;
    x = (x | x << 2) & 0x333u;
    return (x | x << 1) & 0x555u;
}

static uint32_t sfield__gather_bits(uint32_t x)
{
    x &= 0x555u;
    x = (x | x >> 1) & 0x333u;
    x = (x | x >> 2) & 0x30fu;
    return (x | x >> 4) & 0x3fu;
}

static uint32_t sfield__texel_number(uint32_t side, uint32_t face, uint32_t x, uint32_t y)
{
    return face * side * side + (sfield__spread_bits(x) | sfield__spread_bits(y) << 1);
}

static void sfield__texel_place(uint32_t side, uint32_t texel, uint32_t *face, uint32_t *x, uint32_t *y)
{
    uint32_t m = texel & (side * side - 1);
    *face = texel / (side * side);
    *x = sfield__gather_bits(m);
    *y = sfield__gather_bits(m >> 1);
}

static int sfield__is_side(uint32_t side, uint32_t least)
{
    return side >= least && side <= 64 && (side & (side - 1)) == 0;
}

/* Writes the 16 Gauss-Legendre points of a texel: unit directions; weights whose sum is its solid angle. */
static void sfield__texel_points(uint32_t side, uint32_t texel, double points[16][4])
{
    static const double at[4] = { -0.86113631159405257522, -0.33998104358485626480, 0.33998104358485626480,
                                  0.86113631159405257522 };
    static const double weight[4] = { 0.34785484513745385737, 0.65214515486254614263, 0.65214515486254614263,
                                      0.34785484513745385737 };
    uint32_t face, x, y;
    uint32_t i, j;
    sfield__texel_place(side, texel, &face, &x, &y);
    for (j = 0; j < 4; j++)
        for (i = 0; i < 4; i++) {
            double *p = points[4 * j + i], s = (2.0 * x + 1 + at[i]) / side - 1,
                   t = (2.0 * y + 1 + at[j]) / side - 1;
            double length = sqrt(1 + s * s + t * t);
            sfield__from_face(face, s, t, p);
            p[0] /= length;
            p[1] /= length;
            p[2] /= length;
            p[3] = weight[i] * weight[j] / ((double)side * side * length * length * length);
        }
}

SFIELD_DEF float sfield_cube_texel(uint32_t side, uint32_t texel, float direction[3])
{
    double points[16][4], sum = 0, d[3], length;
    uint32_t face, x, y, i;
    if (!sfield__is_side(side, 2) || texel >= 6 * side * side || !direction) return 0;
    sfield__texel_points(side, texel, points);
    for (i = 0; i < 16; i++) sum += points[i][3];
    sfield__texel_place(side, texel, &face, &x, &y);
    sfield__from_face(face, (2.0 * x + 1) / side - 1, (2.0 * y + 1) / side - 1, d);
    length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (i = 0; i < 3; i++) direction[i] = (float)(d[i] / length);
    return (float)sum;
}

SFIELD_DEF uint32_t sfield_cube_find(uint32_t side, const float direction[3])
{
    float q[3];
    uint32_t face, x, y;
    if (!sfield__is_side(side, 2) || !direction) return 0;
    face = sfield__face_of(direction);
    sfield__to_face(face, direction, q);
    if (!(q[2] > 0)) return 0;
    q[0] = (q[0] / q[2] + 1) * 0.5f * (float)side;
    q[1] = (q[1] / q[2] + 1) * 0.5f * (float)side;
    x = q[0] > 0 ? (uint32_t)q[0] : 0;
    y = q[1] > 0 ? (uint32_t)q[1] : 0;
    return sfield__texel_number(side, face, x < side ? x : side - 1, y < side ? y : side - 1);
}

/* Integrates every basis function over one texel. */
static void sfield__texel_basis(uint32_t bands, uint32_t side, uint32_t texel, float *out)
{
    double points[16][4], y[SFIELD_MAX_COEFS], sum[SFIELD_MAX_COEFS] = { 0 };
    uint32_t i, k;
    sfield__texel_points(side, texel, points);
    for (i = 0; i < 16; i++) {
        sfield_sh_basis(bands, points[i], y);
        for (k = 0; k < bands * bands; k++) sum[k] += points[i][3] * y[k];
    }
    for (k = 0; k < bands * bands; k++) out[k] = (float)sum[k];
}

SFIELD_DEF sfield_result sfield_cube_basis(uint32_t bands, uint32_t side, uint32_t texel, float *out)
{
    if (bands < 1 || bands > SFIELD_MAX_BANDS || !sfield__is_side(side, 2) || texel >= 6 * side * side ||
        !out)
        return SFIELD_ERR_ARGUMENT;
    sfield__texel_basis(bands, side, texel, out);
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_sh_project(uint32_t bands, uint32_t side, const float *texels,
                                           uint32_t channels, float *coefs)
{
    double sum[3 * SFIELD_MAX_COEFS] = { 0 };
    float y[SFIELD_MAX_COEFS];
    uint32_t n = bands * bands, i, k, c;
    if (bands < 1 || bands > SFIELD_MAX_BANDS || !sfield__is_side(side, 2) || !texels || !coefs ||
        channels < 1 || channels > 3)
        return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < 6 * side * side; i++) {
        sfield__texel_basis(bands, side, i, y);
        for (c = 0; c < channels; c++)
            for (k = 0; k < n; k++) sum[c * n + k] += (double)texels[i * channels + c] * (double)y[k];
    }
    for (k = 0; k < channels * n; k++) coefs[k] = (float)sum[k];
    return SFIELD_OK;
}

/* ==== src/shadowfield/wavelets.h ==== */

/* ---- wavelets: Haar transforms of cubes, and products of coefficients ---- */

/* Does what sfield__haar_level does for a multiple of four squares. */
static void sfield__haar_squares16(uint32_t squares, const float *c, float *up, float *out, int simd);

/* Writes a level's wavelets to out, and its squares' scaling coefficients to up. Morton order makes both a
   walk through memory. */
static void sfield__haar_level(uint32_t squares, const float *c, float *up, float *out)
{
    uint32_t i;
    for (i = 0; i < squares; i++) {
        float a = c[4 * i] + c[4 * i + 1], b = c[4 * i] - c[4 * i + 1], d = c[4 * i + 2] + c[4 * i + 3];
        float e = c[4 * i + 2] - c[4 * i + 3], *w = out + squares + 3 * i;
        w[0] = 0.5f * (b + e);
        w[1] = 0.5f * (a - d);
        w[2] = 0.5f * (b - e);
        up[i] = 0.5f * (a + d);
    }
}

/* Transforms one face. Every instruction set gives the same bits. */
static void sfield__haar_face(uint32_t side, const float *texels, float *out, int simd)
{
    float scaling[1365], *up = scaling;
    uint32_t squares;
    for (squares = side * side / 4; squares; up += squares, squares /= 4) {
        if (squares > 1) sfield__haar_squares16(squares, texels, up, out, simd);
        else sfield__haar_level(squares, texels, up, out);
        texels = up;
    }
    out[0] = texels[0];
}

static void sfield__haar_up(const float *w, uint32_t squares, const float *scaling, float *out)
{
    uint32_t i;
    for (i = squares; i-- > 0;) {               /* from the end, so that out may be scaling */
        float s = scaling[i], x = w[3 * i], y = w[3 * i + 1];
        float z = w[3 * i + 2], *c = out + 4 * i;
        c[0] = 0.5f * (s + x + y + z);
        c[1] = 0.5f * (s - x + y - z);
        c[2] = 0.5f * (s + x - y - z);
        c[3] = 0.5f * (s - x - y + z);
    }
}

static void sfield__haar_texels(uint32_t side, const float *coefs, float *texels)
{
    uint32_t face, squares, n = side * side;
    for (face = 0; face < 6; face++, coefs += n, texels += n) {
        texels[0] = coefs[0];
        for (squares = 1; squares < n; squares *= 4)
            sfield__haar_up(coefs + squares, squares, texels, texels);
    }
}

/* Transforms the six faces of a cube. The caller knows what the processor can do: to ask it for every cube
   costs several times as much as the transform under virtual machines. */
static void sfield__haar_cube(uint32_t side, const float *texels, float *coefs, int simd)
{
    uint32_t face, n = side * side;
    for (face = 0; face < 6; face++) sfield__haar_face(side, texels + face * n, coefs + face * n, simd);
}

SFIELD_DEF sfield_result sfield_haar_forward(uint32_t side, const float *texels, float *coefs)
{
    if (!sfield__is_side(side, 2) || !texels || !coefs || texels == coefs) return SFIELD_ERR_ARGUMENT;
    sfield__haar_cube(side, texels, coefs, sfield__simd_level());
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_haar_inverse(uint32_t side, const float *coefs, float *texels)
{
    if (!sfield__is_side(side, 2) || !texels || !coefs || texels == coefs) return SFIELD_ERR_ARGUMENT;
    sfield__haar_texels(side, coefs, texels);
    return SFIELD_OK;
}

/* Marks are a byte for each square of a face, not 0 if the square or one below it has coefficients, level
   after level: number sfield__mark_base(n) + i is square i of a level of n squares. */
#define SFIELD__MARKS 1365u                     /* (4^6 - 1) / 3 squares a face of 64 x 64 */

static uint32_t sfield__mark_base(uint32_t squares) { return (squares - 1) / 3; }

static void sfield__mark_squares(uint32_t side, const float *coefs, uint8_t *marks)
{
    uint32_t squares, i;
    for (squares = side * side / 4; squares; squares /= 4)
        for (i = 0; i < squares; i++) {
            const float *w = coefs + squares + 3 * i;
            uint8_t used = w[0] != 0 || w[1] != 0 || w[2] != 0;
            if (squares < side * side / 4) {
                const uint8_t *below = marks + sfield__mark_base(4 * squares) + 4 * i;
                used = (uint8_t)(used | below[0] | below[1] | below[2] | below[3]);
            }
            marks[sfield__mark_base(squares) + i] = used;
        }
}

typedef struct sfield__trees {
    const float   *a, *b;
    float         *out;             /* of a face */
    const uint8_t *marks_a, *marks_b;
    uint32_t       leaves;          /* squares of the finest level that has wavelets */
} sfield__trees;

/* Writes the product where one operand is constant below: the other operand, scaled. */
static void sfield__scale_tree(const sfield__trees *t, const float *from, const uint8_t *marks, float factor,
                               uint32_t squares, uint32_t i)
{
    uint32_t k;
    if (!marks[sfield__mark_base(squares) + i]) return;
    for (k = 0; k < 3; k++) t->out[squares + 3 * i + k] = factor * from[squares + 3 * i + k];
    for (k = 0; k < 4 && squares < t->leaves; k++)
        sfield__scale_tree(t, from, marks, factor, 4 * squares, 4 * i + k);
}

/* Returns the mean of the product over square i of a level, given the means of both; writes its wavelets.
   Where both have detail the product is that of the quarters, put together again: every tripling coefficient
   of Ng et al. in one step. Depth at most 6. */
static float sfield__multiply_tree(const sfield__trees *t, float mean_a, float mean_b, uint32_t squares,
                                   uint32_t i, float side)
{
    uint32_t k, mark = sfield__mark_base(squares) + i;
    const float *a = t->a + squares + 3 * i, *b = t->b + squares + 3 * i;
    float *w = t->out + squares + 3 * i, c[4], scale = 1 / side;
    if (!t->marks_a[mark] || !t->marks_b[mark]) {
        if (t->marks_a[mark]) sfield__scale_tree(t, t->a, t->marks_a, mean_b, squares, i);
        if (t->marks_b[mark]) sfield__scale_tree(t, t->b, t->marks_b, mean_a, squares, i);
        return mean_a * mean_b;
    }
    for (k = 0; k < 4; k++) {
        float x = k & 1 ? -scale : scale, y = k & 2 ? -scale : scale, z = k == 0 || k == 3 ? scale : -scale;
        float p = mean_a + x * a[0] + y * a[1] + z * a[2], q = mean_b + x * b[0] + y * b[1] + z * b[2];
        c[k] =
            squares < t->leaves ? sfield__multiply_tree(t, p, q, 4 * squares, 4 * i + k, 0.5f * side) : p * q;
    }
    w[0] = 0.25f * side * (c[0] - c[1] + c[2] - c[3]);
    w[1] = 0.25f * side * (c[0] + c[1] - c[2] - c[3]);
    w[2] = 0.25f * side * (c[0] - c[1] - c[2] + c[3]);
    return 0.25f * (c[0] + c[1] + c[2] + c[3]);
}

static void sfield__haar_multiply(uint32_t side, const float *a, const float *b, float *out)
{
    uint8_t marks[2][SFIELD__MARKS];
    uint32_t face, n = side * side;
    sfield__trees t;
    memset(out, 0, 6 * n * sizeof *out);
    t.marks_a = marks[0];
    t.marks_b = marks[1];
    t.leaves = n / 4;
    for (face = 0; face < 6; face++) {
        t.a = a + face * n;
        t.b = b + face * n;
        t.out = out + face * n;
        sfield__mark_squares(side, t.a, marks[0]);
        sfield__mark_squares(side, t.b, marks[1]);
        t.out[0] = (float)side *
                   sfield__multiply_tree(&t, t.a[0] / (float)side, t.b[0] / (float)side, 1, 0, (float)side);
    }
}

SFIELD_DEF sfield_result sfield_haar_product(uint32_t side, const float *a, const float *b, float *out)
{
    if (!sfield__is_side(side, 2) || !a || !b || !out || out == a || out == b) return SFIELD_ERR_ARGUMENT;
    sfield__haar_multiply(side, a, b, out);
    return SFIELD_OK;
}

/* ==== src/shadowfield/field_block.h ==== */

/* ---- fields: the block that is kept and written ---- */

/* 32-bit words, little-endian in files, in the host's order in memory:

     header    SFIELD__HEADER words
     radii     shells floats, in r (SELF: none)
     SH        scale, then bias: `stride` floats a group (a shell of a frame; SELF: one), then the samples,
               `stride` bytes each: per channel n^2 bytes filled up to a multiple of 8. value = scale byte +
               bias
     HAAR      samples + 1 offsets into the entries, samples scales (floats), entries: `stride` words each:
               index << 16 | value, or index << 16 | r, g << 16 | b; values are signed 16 bit times the
               sample's scale

   Sample ((frame shells + shell) 6 + face) side^2 + y side + x of a field lies on the grid of nodes of a
   face, edges and corners included: those are stored by each face that has them, so that no query looks
   beyond its face. */
enum {
    SFIELD__MAGIC = 0x444c4653,     /* "SFLD" */
    SFIELD__FORMAT = 1,
    SFIELD__HEADER = 32
};

/* These numbers stand in files. */
typedef enum sfield__kind { SFIELD__KIND_OCCLUSION, SFIELD__KIND_SOURCE, SFIELD__KIND_SELF } sfield__kind;

typedef struct sfield__header {     /* 32-bit fields only */
    uint32_t magic, format, bytes, crc;
    uint32_t kind, basis, logarithm, bands;
    uint32_t cube_side, shells, position_side, spacing;
    uint32_t frames, loop;
    uint32_t channels, samples, stride, entries;
    float center[3], radius, inscribed;
    float frames_per_second, window;
    uint32_t shard_begin, shard_end, reserved[5];
} sfield__header;

struct sfield_field {
    sfield__allocator allocator;
    sfield__logger    log;          /* of the system that the field was made with */
    sfield__header    h;
    uint32_t         *words;        /* the block */
    const float      *radii, *scale, *bias;
    const uint8_t    *sample;
    const uint32_t   *offset, *entry;
    const float      *sample_scale;
    size_t            word_count;   /* of the block, samples of SH left out: these are bytes */
    float             radius2[64];  /* (radius of a shell / r)^2 */
    float             measure[64];  /* what weights are linear in, of each shell */
    uint32_t          planes;       /* floats a channel: n^2 up to a multiple of 8 */
    uint32_t          tone;         /* channels are multiples of this one, or 3 */
    float             ratio[3];
    float            *angle;        /* occlusion in wavelets: the solid angles of a face's texels, as
                                       wavelets */
};

static uint32_t sfield__groups(const sfield__header *h)
{
    return h->kind == SFIELD__KIND_SELF ? 1 : h->shells * h->frames;
}
static uint32_t sfield__planes(uint32_t bands) { return (bands * bands + 7) / 8 * 8; }

/* Returns a bound on every value of a field, coefficient or wavelet, far above what a build makes: with it no
   light comes near the largest float. What is hidden is 0..1 of each texel, radiance is 1e18 at most. */
static float sfield__most_value(const sfield__header *h)
{
    return h->kind == SFIELD__KIND_SOURCE ? 1e20f : 1e4f;
}

/* Counts the words before the bytes of harmonics, or all words of wavelets. */
static uint64_t sfield__block_words(const sfield__header *h)
{
    uint64_t n = SFIELD__HEADER + (uint64_t)h->shells;
    if (h->basis == SFIELD_BASIS_SH) return n + 2 * (uint64_t)sfield__groups(h) * h->stride;
    return n + 2 * (uint64_t)h->samples + 1 + (uint64_t)h->entries * h->stride;
}

static uint64_t sfield__block_bytes(const sfield__header *h)
{
    return 4 * sfield__block_words(h) + (h->basis == SFIELD_BASIS_SH ? (uint64_t)h->samples * h->stride : 0);
}

/* Returns what weights are linear in: the solid angle that a sphere of radius 1 fills at distance d > 1, over
   2 pi; below, and for lights, 1 / d^2; for uniform shells -d. */
SFIELD__INLINE float sfield__measure_of(float d2, uint32_t kind, uint32_t spacing)
{
    float inverse = 1 / d2, u = inverse < 1 ? inverse : 1.0f, g = u / (1 + sqrtf(1 - u));
    if (spacing == SFIELD_SPACING_UNIFORM) return -sqrtf(d2);
    return kind == SFIELD__KIND_SOURCE || d2 < 1 ? inverse : g;
}

static void sfield__bind_block(sfield_field *f)
{
    const sfield__header *h = &f->h;
    const uint32_t *w = f->words + SFIELD__HEADER;
    f->word_count = (size_t)sfield__block_words(h);
    f->planes = sfield__planes(h->bands);
    f->radii = (const float *)(const void *)w;
    w += h->shells;
    if (h->basis == SFIELD_BASIS_SH) {
        f->scale = (const float *)(const void *)w;
        f->bias = f->scale + (size_t)sfield__groups(h) * h->stride;
        f->sample = (const uint8_t *)(f->words + f->word_count);
    } else {
        f->offset = w;
        f->sample_scale = (const float *)(const void *)(w + h->samples + 1);
        f->entry = w + 2 * (size_t)h->samples + 1;
    }
}

#ifndef SFIELD_WITHOUT_WAVELETS
/* Transforms the solid angles of a face's texels. Haar wavelets are orthonormal, so that the solid angle that
   a list hides is its dot product with these, the same for all six faces. */
static void sfield__find_angles(sfield_field *f)
{
    float texels[4096], direction[3];
    uint32_t i;
    for (i = 0; i < f->h.cube_side * f->h.cube_side; i++)
        texels[i] = sfield_cube_texel(f->h.cube_side, i, direction);
    sfield__haar_face(f->h.cube_side, texels, f->angle, 0);
}
#endif

/* Takes the radii of the shells from a block that is complete. */
static void sfield__bind_shells(sfield_field *f)
{
    uint32_t k;
    sfield__bind_block(f);
#ifndef SFIELD_WITHOUT_WAVELETS
    if (f->angle) sfield__find_angles(f);
#endif
    for (k = 0; k < f->h.shells; k++) {
        f->radius2[k] = f->radii[k] * f->radii[k];
        f->measure[k] = sfield__measure_of(f->radius2[k], f->h.kind, f->h.spacing);
    }
}

/* Allocates the block that a header describes. The header itself is written at the end of a build. */
static sfield_result sfield__alloc_field(const sfield__allocator *a, const sfield__logger *log,
                                         const sfield__header *h, sfield_field **out)
{
    const int angles = h->basis == SFIELD_BASIS_HAAR && h->kind == SFIELD__KIND_OCCLUSION;
    uint64_t bytes = sfield__block_bytes(h);
    sfield_field *f;
    if (bytes > 0xffffffffu || bytes > SIZE_MAX - 8) return SFIELD_ERR_LIMIT;
    f = (sfield_field *)sfield__alloc(a, sizeof *f +
                                             (angles ? h->cube_side * h->cube_side * sizeof *f->angle : 0));
    if (!f) return SFIELD_ERR_ALLOC;
    memset(f, 0, sizeof *f);
    f->angle = angles ? (float *)(void *)(f + 1) : NULL;
    f->allocator = *a;
    f->log = *log;
    f->h = *h;
    f->h.bytes = (uint32_t)bytes;
    f->words = (uint32_t *)sfield__alloc(a, (size_t)bytes + 8);     /* kernels read as far past samples */
    if (!f->words) {
        sfield__free(a, f);
        return SFIELD_ERR_ALLOC;
    }
    memset(f->words + bytes / 4, 0, 8);
    sfield__bind_block(f);
    *out = f;
    return SFIELD_OK;
}

SFIELD_DEF void sfield_free(sfield_field *field)
{
    sfield__allocator a;
    if (!field) return;
    a = field->allocator;
    sfield__free(&a, field->words);
    sfield__free(&a, field);
}

/* Returns whether everything in the header is right, so that sizes computed from it are true. */
static int sfield__header_good(const sfield__header *h)
{
    uint32_t i, self = h->kind == SFIELD__KIND_SELF, haar = h->basis == SFIELD_BASIS_HAAR;
    if (h->kind > SFIELD__KIND_SELF || h->basis < SFIELD_BASIS_SH || h->basis > SFIELD_BASIS_HAAR) return 0;
#ifdef SFIELD_WITHOUT_WAVELETS
    if (haar) return 0;
#endif
    if (h->logarithm > 1 || (h->logarithm && (h->kind != SFIELD__KIND_OCCLUSION || haar)) || h->loop > 1)
        return 0;
    if (haar ? h->bands != 0 : h->bands < 1 || h->bands > SFIELD_MAX_BANDS) return 0;
    if (!sfield__is_side(h->cube_side, 4) || h->channels != (h->kind == SFIELD__KIND_SOURCE ? 3u : 1u))
        return 0;
    if (h->spacing < SFIELD_SPACING_GEOMETRIC || h->spacing > SFIELD_SPACING_UNIFORM) return 0;
    if (h->frames < 1 || h->frames > 256 || (h->frames > 1 && h->kind != SFIELD__KIND_SOURCE)) return 0;
    if (!sfield__in(h->frames_per_second, 1e-6f, 1e6f) || !sfield__in(h->window, 0, 1e6f)) return 0;
    for (i = 0; i < 3; i++)
        if (!sfield__in(h->center[i], -1e18f, 1e18f)) return 0;
    if (!sfield__in(h->radius, 1e-18f, 1e18f) || !sfield__in(h->inscribed, 0, h->radius)) return 0;
    for (i = 0; i < 5; i++)
        if (h->reserved[i]) return 0;
    if (h->shard_end ? self || h->shard_begin >= h->shard_end || h->shard_end > sfield__groups(h)
                     : h->shard_begin)
        return 0;
    if (haar ? h->stride != (h->channels == 3 ? 2u : 1u)
             : h->stride != h->channels * sfield__planes(h->bands))
        return 0;
    if (!haar && h->entries) return 0;
    if (self) return h->shells == 0 && h->position_side == 0 && h->samples >= 1;
    if (h->shells < 2 || h->shells > 64 || h->position_side < 2 || h->position_side > 64) return 0;
    return h->samples == h->frames * h->shells * 6 * h->position_side * h->position_side;
}

SFIELD_DEF void sfield_get_info(const sfield_field *field, sfield_info *out)
{
    const sfield__header *h;
    if (!field || !out) return;
    h = &field->h;
    memset(out, 0, sizeof *out);
    out->kind = (sfield_kind)(h->kind + 1);
    out->basis = (sfield_basis)h->basis;
    out->bands = h->bands;
    out->cube_side = h->cube_side;
    out->shell_count = h->shells;
    out->position_side = h->position_side;
    out->frame_count = h->frames;
    out->spacing = (sfield_spacing)h->spacing;
    out->logarithm = (int)h->logarithm;
    out->sample_count = h->samples;
    out->coefficient_count = h->entries;
    out->bytes = h->bytes;
    memcpy(out->center, h->center, sizeof h->center);
    out->radius = h->radius;
    out->inscribed = h->inscribed;
    out->inner = h->shells ? field->radii[0] : 0;
    out->outer = h->shells ? field->radii[h->shells - 1] : 0;
    out->shard_begin = h->shard_begin;
    out->shard_end = h->shard_end;
}

/* ==== src/shadowfield/field_file.h ==== */

/* ---- fields: files, and shards of a field joined ---- */

static void sfield__write_words(uint8_t *to, const uint32_t *from, size_t count)
{
    size_t i;
    if (sfield__host_is_little_endian()) memcpy(to, from, 4 * count);
    else
        for (i = 0; i < count; i++) sfield__put_u32(to + 4 * i, from[i]);
}

/* How many bytes, or samples of wavelets, lie between two calls of progress, which takes milliseconds. */
enum { SFIELD__STEP = 1 << 18, SFIELD__STEP_SAMPLES = 1024 };

/* Takes a call's allocator and progress. Returns 0 if the allocator has one of its two functions alone. */
static int sfield__services_of(const sfield_system *system, sfield__allocator *a, sfield__part *part)
{
    if (!sfield__system_good(system)) return 0;
    *a = sfield__allocator_of(system);
    part->progress = system ? system->progress : NULL;
    part->user = system ? system->user : NULL;
    part->from = 0;
    part->to = 1;
    return 1;
}

/* Adds bytes to a checksum. Returns 0 if the caller cancels. */
static int sfield__add_to_crc(uint32_t *crc, const uint8_t *bytes, size_t size, sfield__part part)
{
    size_t i, n;
    for (i = 0; i < size; i += n) {
        if (sfield__cancelled(&part, i, size, 1)) return 0;
        n = size - i < SFIELD__STEP ? size - i : (size_t)SFIELD__STEP;
        *crc = sfield__crc32(*crc, bytes + i, n);
    }
    return 1;
}

/* Computes the checksum of a field's bytes as a file has them, from the word after the checksum itself to the
   end. Returns 0 if the caller cancels. */
static int sfield__checksum(const sfield_field *f, const sfield__part *part, uint32_t *crc)
{
    const size_t total = f->word_count - 4, sampled = f->h.bytes - 4 * f->word_count;
    const float share = (float)(4.0 * (double)total / (4.0 * (double)total + (double)sampled));
    const sfield__part words = sfield__part_of(part, 0, share);
    uint8_t chunk[1024];
    size_t i, n;
    *crc = 0;
    for (i = 0; i < total; i += n) {
        if (sfield__cancelled(&words, i, total, SFIELD__STEP / 4)) return 0;
        n = total - i < 256 ? total - i : 256;
        sfield__write_words(chunk, f->words + 4 + i, n);
        *crc = sfield__crc32(*crc, chunk, 4 * n);
    }
    return sfield__add_to_crc(crc, f->sample, sampled, sfield__part_of(part, share, 1));
}

/* Returns whether coefficient k of group g is everywhere `ratio` times coefficient `of`, to the bits that are
   kept. The first coefficient of the channel that `of` is in says how much that is. */
static int sfield__is_multiple(const sfield_field *f, uint32_t g, uint32_t k, uint32_t of, float ratio)
{
    const size_t stride = f->h.stride, samples = f->h.samples / (f->h.shells * f->h.frames);
    const float *scale = f->scale + g * stride, *bias = f->bias + g * stride;
    const uint32_t first = of / f->planes * f->planes;
    const float s = scale[k], b = bias[k], u = ratio * scale[of], v = ratio * bias[of];
    const float most = s + 1e-5f * ratio * fabsf(bias[first] + 255 * scale[first]);
    const uint8_t *q = f->sample + samples * g * stride;
    size_t i;
    for (i = 0; i < samples; i++, q += stride)
        if (!(fabsf(s * (float)q[k] + b - u * (float)q[of] - v) <= most)) return 0;
    return 1;
}

/* Finds the channel that the others are multiples of, as those of lamps of one colour are, to the bits that
   are kept: then that channel is enough. Returns 0 if the caller cancels. */
static int sfield__find_tone(sfield_field *f, sfield__part part)
{
    const uint32_t n = f->planes;
    uint32_t c, k, g, t = 0;
    f->tone = 3;
    if (f->h.channels != 3 || f->h.basis != SFIELD_BASIS_SH || f->h.shard_end) return 1;
    for (c = 0; c < 3; c++) {
        /* This is the greatest mean that a sample of the first shell has. */
        f->ratio[c] = f->bias[c * n] + 255 * f->scale[c * n];
        if (f->ratio[c] > f->ratio[t]) t = c;
    }
    if (!(f->ratio[t] > 0)) return 1;
    for (c = 0; c < 3; c++) f->ratio[c] = c == t ? f->ratio[c] : f->ratio[c] / f->ratio[t];
    f->ratio[t] = 1;
    for (g = 0; g < sfield__groups(&f->h); g++) {
        if (sfield__cancelled(&part, g, sfield__groups(&f->h), 1)) return 0;
        for (c = 0; c < 3; c++)
            for (k = 0; k < n && c != t; k++)
                if (!sfield__is_multiple(f, g, c * n + k, t * n + k, f->ratio[c])) return 1;
    }
    f->tone = t;
    return 1;
}

/* Writes the header into a block, with its checksum. Returns 0 if the caller cancels. */
static int sfield__seal_block(sfield_field *f, const sfield__part *part)
{
    sfield__part first;
    memcpy(f->words, &f->h, sizeof f->h);
    first = sfield__part_of(part, 0, 0.9f);
    if (!sfield__checksum(f, &first, &f->h.crc)) return 0;
    memcpy(f->words, &f->h, sizeof f->h);
    return sfield__find_tone(f, sfield__part_of(part, 0.9f, 1));
}

SFIELD_DEF size_t sfield_bytes(const sfield_field *field) { return field ? field->h.bytes : 0; }

SFIELD_DEF sfield_result sfield_write(const sfield_field *field, void *memory, size_t memory_bytes)
{
    sfield__logger log;
    if (!field) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_for(&field->log, "sfield_write");
    if (!memory) return sfield__fail_null(&log, "memory");
    if (!sfield__check_value(&log, memory_bytes >= field->h.bytes, "memory_bytes", (double)memory_bytes,
                             "at least what sfield_bytes returns"))
        return SFIELD_ERR_MEMORY;
    sfield__write_words((uint8_t *)memory, field->words, field->word_count);
    if (field->h.basis == SFIELD_BASIS_SH)
        memcpy((uint8_t *)memory + 4 * field->word_count, field->sample,
               (size_t)field->h.samples * field->h.stride);
    return SFIELD_OK;
}

#ifndef SFIELD_WITHOUT_WAVELETS
/* Checks that offsets rise, that scales are in range, and that indices rise in each list. */
static sfield_result sfield__check_lists(const sfield_field *f, sfield__part part)
{
    const sfield__header *h = &f->h;
    const float most = sfield__most_value(h) / 32767;
    uint32_t i, k, cells = 6 * h->cube_side * h->cube_side;
    if (f->offset[0] != 0 || f->offset[h->samples] != h->entries) return SFIELD_ERR_FORMAT;
    /* shards: nothing outside, so that sfield_merge fits */
    k = h->shard_end ? h->samples / sfield__groups(h) : 0;
    if (k && (f->offset[h->shard_begin * k] != 0 || f->offset[h->shard_end * k] != h->entries))
        return SFIELD_ERR_FORMAT;
    for (i = 0; i < h->samples; i++) {
        if (sfield__cancelled(&part, i, h->samples, SFIELD__STEP_SAMPLES)) return SFIELD_ERR_CANCELLED;
        if (f->offset[i] > f->offset[i + 1] || f->offset[i + 1] > h->entries) return SFIELD_ERR_FORMAT;
        if (!sfield__in(f->sample_scale[i], 0, most)) return SFIELD_ERR_FORMAT;
        for (k = f->offset[i]; k < f->offset[i + 1]; k++) {
            uint32_t index = f->entry[(size_t)k * h->stride] >> 16;
            if (index >= cells || (k > f->offset[i] && index <= f->entry[(size_t)(k - 1) * h->stride] >> 16))
                return SFIELD_ERR_FORMAT;
        }
    }
    return SFIELD_OK;
}
#endif

static sfield_result sfield__check_content(const sfield_field *f, sfield__part part)
{
    const sfield__header *h = &f->h;
    const float most = sfield__most_value(h);
    uint32_t i, count = sfield__groups(h) * h->stride;
    for (i = 0; i < h->shells; i++)
        if (!sfield__in(f->radii[i], 1e-6f, 1000) || (i && f->radii[i] <= f->radii[i - 1] * 1.0001f))
            return SFIELD_ERR_FORMAT;
    if (h->basis == SFIELD_BASIS_SH) {
        for (i = 0; i < count; i++)
            if (!sfield__in(255 * f->scale[i], -most, most) || !sfield__in(f->bias[i], -most, most))
                return SFIELD_ERR_FORMAT;
        return SFIELD_OK;
    }
#ifndef SFIELD_WITHOUT_WAVELETS
    return sfield__check_lists(f, part);
#else
    (void)part;
    return SFIELD_ERR_FORMAT;
#endif
}

/* Reads the block from a file's bytes. Returns 0 if the caller cancels. */
static int sfield__read_words(sfield_field *f, const uint8_t *bytes, sfield__part part)
{
    const size_t total = f->h.bytes, words = 4 * f->word_count;
    size_t i, k, n;
    for (i = 0; i < total; i += n) {
        if (sfield__cancelled(&part, i, total, 1)) return 0;
        n = i < words ? words - i : total - i;
        n = n < SFIELD__STEP ? n : (size_t)SFIELD__STEP;
        if (i < words)
            for (k = i / 4; k < (i + n) / 4; k++) f->words[k] = sfield__get_u32(bytes + 4 * k);
        else memcpy((uint8_t *)f->words + i, bytes + i, n);
    }
    return 1;
}

/* Fills a field from a file whose header and checksum are right. */
static sfield_result sfield__take_file(sfield_field *f, const uint8_t *bytes, const sfield__part *part)
{
    sfield_result result;
    if (!sfield__read_words(f, bytes, sfield__part_of(part, 0, 0.3f))) return SFIELD_ERR_CANCELLED;
    sfield__bind_shells(f);
    result = sfield__check_content(f, sfield__part_of(part, 0.3f, 0.7f));
    if (result != SFIELD_OK) return result;
    return sfield__find_tone(f, sfield__part_of(part, 0.7f, 1)) ? SFIELD_OK : SFIELD_ERR_CANCELLED;
}

SFIELD_DEF sfield_result sfield_open(const void *data, size_t bytes, const sfield_system *system,
                                     sfield_field **out)
{
    const sfield__logger log = sfield__logger_of(system, "sfield_open");
    const uint8_t *from = (const uint8_t *)data;
    uint32_t words[SFIELD__HEADER], i, crc = 0;
    sfield__allocator a;
    sfield__part part, rest;
    sfield__header h;
    sfield_field *f;
    sfield_result result;
    if (!data || !out) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, data ? "out" : "data", "is NULL");
    if (!sfield__services_of(system, &a, &part)) return sfield__fail_allocator(&log);
    if (bytes < sizeof h || sfield__get_u32(from) != SFIELD__MAGIC)
        return sfield__fail(&log, SFIELD_ERR_FORMAT, "data", "is not a file of shadowfield.h");
    if (sfield__get_u32(from + 4) != SFIELD__FORMAT) {
        sfield__log_value(&log, "the format of data", (double)sfield__get_u32(from + 4), "1");
        return SFIELD_ERR_VERSION;
    }
    for (i = 0; i < SFIELD__HEADER; i++) words[i] = sfield__get_u32(from + 4 * i);
    memcpy(&h, words, sizeof h);
#ifdef SFIELD_WITHOUT_WAVELETS
    if (h.basis == SFIELD_BASIS_HAAR)
        return sfield__fail(&log, SFIELD_ERR_MISMATCH, "data",
                            "holds wavelets, which this header was joined without");
#endif
    if (h.bytes != bytes || !sfield__header_good(&h) || sfield__block_bytes(&h) != bytes)
        return sfield__fail(&log, SFIELD_ERR_FORMAT, "data",
                            "has a damaged header, or another size than it says");
    if (!sfield__add_to_crc(&crc, from + 16, bytes - 16, sfield__part_of(&part, 0, 0.7f)))
        return SFIELD_ERR_CANCELLED;
    if (crc != h.crc)
        return sfield__fail(&log, SFIELD_ERR_FORMAT, "data", "does not have the checksum that it says");
    result = sfield__alloc_field(&a, &log, &h, &f);
    if (result != SFIELD_OK) return sfield__fail(&log, result, "data", "needs more memory than there is");
    rest = sfield__part_of(&part, 0.7f, 1);
    result = sfield__take_file(f, from, &rest);
    if (result == SFIELD_OK) {
        *out = f;
        return SFIELD_OK;
    }
    sfield_free(f);
    if (result == SFIELD_ERR_FORMAT) sfield__log_text(&log, "data", "holds numbers out of their range");
    return result;
}

/* Returns whether shard b continues where shard a ends, and was made in the same way. */
static int sfield__is_next_shard(const sfield_field *a, const sfield_field *b)
{
    sfield__header x = a->h, y = b->h;
    if (x.shard_end != y.shard_begin || !y.shard_end) return 0;
    x.bytes = x.crc = x.entries = x.shard_begin = x.shard_end = 0;
    y.bytes = y.crc = y.entries = y.shard_begin = y.shard_end = 0;
    return memcmp(&x, &y, sizeof x) == 0 && memcmp(a->radii, b->radii, x.shells * sizeof *a->radii) == 0;
}

/* Copies what a shard has built into the whole. *entries counts the wavelets there. */
static void sfield__join_shard(sfield_field *whole, const sfield_field *shard, uint32_t *entries)
{
    const sfield__header *h = &shard->h;
    size_t samples = h->samples / sfield__groups(h), first = h->shard_begin * samples, stride = h->stride, i;
    size_t groups = h->shard_end - h->shard_begin, at = h->shard_begin * stride;
    uint32_t *words = whole->words + SFIELD__HEADER + h->shells;
    samples *= groups;
    if (h->basis == SFIELD_BASIS_SH) {
        memcpy(words + at, shard->scale + at, 4 * groups * stride);
        memcpy(words + at + sfield__groups(h) * stride, shard->bias + at, 4 * groups * stride);
        memcpy((uint8_t *)(whole->words + whole->word_count) + first * stride, shard->sample + first * stride,
               samples * stride);
        return;
    }
    for (i = first; i < first + samples; i++) words[i + 1] = *entries + shard->offset[i + 1];
    memcpy(words + h->samples + 1 + first, shard->sample_scale + first, 4 * samples);
    if (h->entries)
        memcpy(words + 2 * (size_t)h->samples + 1 + *entries * stride, shard->entry, 4 * h->entries * stride);
    *entries += h->entries;
}

/* Copies all shards into the whole. Returns 0 if the caller cancels. */
static int sfield__join_shards(sfield_field *whole, const sfield_field *const *shards, size_t count,
                            sfield__part part)
{
    uint32_t used = 0;
    size_t i;
    memcpy(whole->words + SFIELD__HEADER, shards[0]->radii, whole->h.shells * sizeof *whole->radii);
    if (whole->h.basis == SFIELD_BASIS_HAAR) whole->words[SFIELD__HEADER + whole->h.shells] = 0;
    for (i = 0; i < count; i++) {
        if (sfield__cancelled(&part, i, count, 1)) return 0;
        sfield__join_shard(whole, shards[i], &used);
    }
    sfield__bind_shells(whole);
    return 1;
}

#ifndef SFIELD_WITHOUT_BUILD
SFIELD_DEF sfield_result sfield_merge(const sfield_field *const *shards, size_t count,
                                      const sfield_system *system, sfield_field **out)
{
    const sfield__logger log = sfield__logger_of(system, "sfield_merge");
    sfield__allocator a;
    sfield__part part, rest;
    uint64_t entries = 0;
    sfield__header h;
    sfield_field *f;
    sfield_result result;
    size_t i;
    if (!shards || !out) return sfield__fail_null(&log, shards ? "out" : "shards");
    if (!sfield__check_value(&log, count > 0, "count", 0, "> 0")) return SFIELD_ERR_ARGUMENT;
    if (!sfield__services_of(system, &a, &part)) return sfield__fail_allocator(&log);
    for (i = 0; i < count; i++) {
        const sfield_field *shard = shards[i];
        if (!shard) return sfield__fail_at(&log, SFIELD_ERR_ARGUMENT, "shards", i, "is NULL");
        if (i ? !sfield__is_next_shard(shards[i - 1], shard) : shard->h.shard_begin || !shard->h.shard_end)
            return sfield__fail_at(&log, SFIELD_ERR_MISMATCH, "shards", i,
                                   "does not go on where the one before ends");
        entries += shards[i]->h.entries;
    }
    h = shards[0]->h;
    if (shards[count - 1]->h.shard_end != sfield__groups(&h))
        return sfield__fail_at(&log, SFIELD_ERR_MISMATCH, "shards", count - 1,
                               "does not end with the last shell");
    if (entries > 0xffffffffu)
        return sfield__fail(&log, SFIELD_ERR_LIMIT, "shards", "have more wavelets than a field");
    h.entries = (uint32_t)entries;
    h.shard_end = 0;
    result = sfield__alloc_field(&a, &log, &h, &f);
    if (result != SFIELD_OK) return sfield__fail(&log, result, "shards", "need more memory than there is");
    rest = sfield__part_of(&part, 0.1f, 1);
    if (!sfield__join_shards(f, shards, count, sfield__part_of(&part, 0, 0.1f)) ||
        !sfield__seal_block(f, &rest)) {
        sfield_free(f);
        return SFIELD_ERR_CANCELLED;
    }
    *out = f;
    return SFIELD_OK;
}
#endif

/* ==== src/shadowfield/query_interpolate.h ==== */

/* ---- queries: where points lie in a field ---- */

typedef struct sfield__place {      /* of 16 points in a field */
    int32_t base[SFIELD__LANES];    /* sample of the inner shell, lower corner */
    int32_t shell[SFIELD__LANES];
    float   fx[SFIELD__LANES], fy[SFIELD__LANES];
    float   w0[SFIELD__LANES], w1[SFIELD__LANES];       /* of the inner and the outer shell */
} sfield__place;

/* Finds where 16 points lie in a field. p: planes of x, y, z about the center, in r, finite. */
static void sfield__locate16(const sfield_field *f, const float *p, sfield__place *out, int simd);

/* Returns the bits of the points with the wanted base. */
static uint32_t sfield__same16(const int32_t *base, int32_t wanted, int simd);

/* Copies n floats, planes of 16, with zeros where a mask has no bit. */
static void sfield__select16(const float *in, uint32_t n, uint32_t mask, float *out, int simd);

/* Finds the frames before and after a time; returns how far it lies between them. Loops wrap both ways. */
static float sfield__frames_at(const sfield_field *f, float time, uint32_t *before, uint32_t *after)
{
    float n = (float)f->h.frames, t = sfield__finite(time) ? time * f->h.frames_per_second : 0;
    *before = *after = 0;
    if (f->h.frames == 1) return 0;
    if (f->h.loop) {
        t = t < 1e7f ? (t > -1e7f ? t : -1e7f) : 1e7f;
        t -= n * floorf(t / n);
    }
    t = t > 0 ? t : 0;
    t = t < n ? t : (f->h.loop ? 0 : n);
    *before = (uint32_t)t < f->h.frames - 1 ? (uint32_t)t : f->h.frames - 1;
    *after = *before + 1 < f->h.frames ? *before + 1 : f->h.loop ? 0 : *before;
    return t - (float)*before < 1 ? t - (float)*before : 0;
}

/* Computes the weights of the four corners of the square of a shell that a lane lies in. */
static void sfield__weigh_corners(const sfield__place *at, int l, float *b)
{
    float x = at->fx[l], y = at->fy[l];
    b[0] = (1 - x) * (1 - y);
    b[1] = x * (1 - y);
    b[2] = (1 - x) * y;
    b[3] = x * y;
}

/* The eight samples between which a point lies, and the weight of each. */
typedef struct sfield__between {
    size_t base, group;             /* sample and scales of the inner shell's first corner */
    float  corner[4];               /* weights of the corners of both shells */
    float  inner, outer;            /* weights of the shells */
} sfield__between;

/* Finds the samples about lane l of a place, in the first frame, with a share of their weight. */
static sfield__between sfield__find_between(const sfield__place *at, int l, float share)
{
    sfield__between b;
    b.base = (size_t)at->base[l];
    b.group = (size_t)at->shell[l];
    sfield__weigh_corners(at, l, b.corner);
    b.inner = at->w0[l] * share;
    b.outer = at->w1[l] * share;
    return b;
}

/* Returns the same samples of another frame of a source. */
static sfield__between sfield__between_of_frame(const sfield_field *f, const sfield__between *first,
                                                uint32_t frame)
{
    sfield__between b = *first;
    b.base += frame * 6 * (size_t)f->h.position_side * f->h.position_side * f->h.shells;
    b.group += frame * f->h.shells;
    return b;
}

/* ---- queries: the eight samples about a point, interpolated ---- */

/* Writes out[k], the sum over eight samples, for k < n, a multiple of 8. Kernels work on sixteen values at
   a time: up to eight floats after out[n - 1] are written, too. */
static void sfield__mix_samples(const sfield_field *f, const sfield__between *at, uint32_t n, float *out,
                                int simd);

/* Transposes n columns, a multiple of 8, of 16 rows that are `stride` floats apart, to n planes of 16. */
static void sfield__rows_to_planes(const float *rows, size_t stride, uint32_t n, float *planes, int simd);

/* Neighbours mostly lie between the same eight samples. The bytes of those are made floats once, and all
   lanes use them, with weights of 0 where they do not belong. Each lane gets the same bits as by
   sfield__mix_samples. */
typedef struct sfield__eight {
    uint32_t     n;                             /* coefficients, a multiple of 8 */
    const float *s0, *b0, *s1, *b1;             /* scale and bias of both shells */
    float        q[8 * SFIELD_MAX_COEFS + 8];   /* of eight samples, corners of the inner shell first */
} sfield__eight;

/* Writes n bytes of each of the eight samples about a place as floats, sample after sample. */
static void sfield__widen_samples(const sfield_field *f, const uint8_t *first, uint32_t n, float *out,
                                  int simd);

/* Groups lanes by the eight samples that they lie between. Returns how many; 0 if lane by lane costs less. */
static uint32_t sfield__group_lanes(const sfield__place *at, uint32_t lanes, uint32_t *group, int simd)
{
    const uint32_t most = sfield__popcount(lanes) / SFIELD__SHARED;
    uint32_t count = 0;
    for (; lanes && count < most; lanes &= ~group[count++]) {
        uint32_t first = 0;
        while (!(lanes >> first & 1)) first++;
        group[count] = sfield__same16(at->base, at->base[first], simd) & lanes;
    }
    return lanes ? 0 : count;
}

/* Loads n coefficients, from one on, of the eight samples whose first sample and group are given. */
static void sfield__load_eight(const sfield_field *f, size_t base, size_t group, uint32_t from, uint32_t n,
                               sfield__eight *c, int simd)
{
    const size_t stride = f->h.stride;
    c->n = n;
    c->s0 = f->scale + group * stride + from;
    c->b0 = f->bias + group * stride + from;
    c->s1 = c->s0 + stride;
    c->b1 = c->b0 + stride;
    sfield__widen_samples(f, f->sample + base * stride + from, n, c->q, simd);
}

/* ==== src/shadowfield/wavelets_query.h ==== */

/* ---- wavelets: lists of coefficients about a point ---- */

/* The lists of wavelets around a point: which samples they belong to, with which weights. */
typedef struct sfield__lists { size_t sample[16]; float weight[16]; uint32_t count; } sfield__lists;

static void sfield__find_lists(const sfield_field *f, const sfield__place *at, int l, float time,
                               sfield__lists *out)
{
    size_t side = f->h.position_side, shell = 6 * side * side;
    uint32_t frame[2], i, j, k;
    float b[4], t = sfield__frames_at(f, time, &frame[0], &frame[1]);
    sfield__weigh_corners(at, l, b);
    out->count = 0;
    for (k = 0; k < 2; k++)
        for (j = 0; j < 2; j++)
            for (i = 0; i < 4; i++) {
                float w = b[i] * (j ? at->w1[l] : at->w0[l]) * (k ? t : 1 - t);
                if (!(w > 0)) continue;
                out->weight[out->count] = w;
                out->sample[out->count++] = frame[k] * f->h.shells * shell + (size_t)at->base[l] + j * shell +
                                            (i & 1) + (i >> 1) * side;
            }
}

/* Returns the number that the low 16 bits hold, in two's complement. */
static float sfield__signed_short(uint32_t bits)
{
    return (float)(int32_t)((bits & 0xffffu) ^ 0x8000u) - 32768.0f;
}

/* Adds weight x what a sample holds to coefs, all channels, in planes `cells` apart. */
static void sfield__scatter_list(const sfield_field *f, size_t sample, float weight, float *coefs)
{
    const uint32_t *e = f->entry + (size_t)f->offset[sample] * f->h.stride,
                   cells = 6 * f->h.cube_side * f->h.cube_side;
    const uint32_t *end = f->entry + (size_t)f->offset[sample + 1] * f->h.stride;
    weight *= f->sample_scale[sample];
    for (; e < end; e += f->h.stride) {
        coefs[e[0] >> 16] += weight * sfield__signed_short(e[0]);
        if (f->h.stride == 1) continue;
        coefs[cells + (e[0] >> 16)] += weight * sfield__signed_short(e[1] >> 16);
        coefs[2 * cells + (e[0] >> 16)] += weight * sfield__signed_short(e[1]);
    }
}

static void sfield__query_haar(const sfield_field *f, const sfield__place *at, int l, float time, float *out)
{
    uint32_t cells = 6 * f->h.cube_side * f->h.cube_side, face, i, c;
    float coefs[4096];
    sfield__lists lists;
    sfield__find_lists(f, at, l, time, &lists);
    memset(out, 0, (size_t)f->h.channels * cells * sizeof *out);
    for (i = 0; i < lists.count; i++) sfield__scatter_list(f, lists.sample[i], lists.weight[i], out);
    for (c = 0; c < f->h.channels; c++)
        for (face = 0; face < 6; face++) {
            uint32_t n = cells / 6, squares;
            float *t = out + c * cells + face * n;
            memcpy(coefs, t, n * sizeof *t);
            for (squares = 1; squares < n; squares *= 4) sfield__haar_up(coefs + squares, squares, t, t);
            for (i = 0; i < n && f->h.kind != SFIELD__KIND_SOURCE; i++) t[i] = 1 - t[i];
        }
}

/* Returns the share of the sphere of directions that an occlusion field of wavelets hides at lane l. */
static float sfield__hidden_share(const sfield_field *f, const sfield__place *at, int l)
{
    const uint32_t in_face = f->h.cube_side * f->h.cube_side - 1;
    sfield__lists lists;
    uint32_t i, k;
    float sum = 0;
    sfield__find_lists(f, at, l, 0, &lists);
    for (i = 0; i < lists.count; i++) {
        const size_t sample = lists.sample[i];
        float own = 0;
        for (k = f->offset[sample]; k < f->offset[sample + 1]; k++)
            own += sfield__signed_short(f->entry[k]) * f->angle[f->entry[k] >> 16 & in_face];
        sum += lists.weight[i] * f->sample_scale[sample] * own;
    }
    return sum * 0.0795774715f;                 /* of 4 pi */
}

/* Writes the texels that a point's own object hides. */
static void sfield__self_haar(const sfield_field *f, size_t point, float *out)
{
    float coefs[4096];
    uint32_t face, squares, m = f->h.cube_side * f->h.cube_side;
    memset(out, 0, 6 * m * sizeof *out);
    sfield__scatter_list(f, point, 1, out);
    for (face = 0; face < 6; face++, out += m) {
        memcpy(coefs, out, m * sizeof *out);
        for (squares = 1; squares < m; squares *= 4) sfield__haar_up(coefs + squares, squares, out, out);
    }
}

/* ==== src/shadowfield/query.h ==== */

/* ---- queries: a field at points ---- */

/* Interpolates harmonics at lane l of a place: n floats, of each channel in turn. */
static void sfield__fetch_lane(const sfield_field *f, const sfield__place *at, int l, float time, uint32_t n,
                          float *out, int simd)
{
    uint32_t before, after, k;
    float t = sfield__frames_at(f, time, &before, &after), next[3 * SFIELD_MAX_COEFS + 8];
    sfield__between b = sfield__find_between(at, l, 1 - t);
    b = sfield__between_of_frame(f, &b, before);
    sfield__mix_samples(f, &b, n, out, simd);
    if (t <= 0) return;
    b = sfield__find_between(at, l, t);
    b = sfield__between_of_frame(f, &b, after);
    sfield__mix_samples(f, &b, n, next, simd);
    for (k = 0; k < n; k++) out[k] += next[k];
}

static void sfield__query_sh(const sfield_field *f, const sfield__place *at, int l, float time, float *out)
{
    float v[3 * SFIELD_MAX_COEFS + 8];
    uint32_t k, c, n = f->h.bands * f->h.bands;
    sfield__fetch_lane(f, at, l, time, f->h.stride, v, 0);
    for (c = 0; c < f->h.channels; c++)
        for (k = 0; k < n; k++) {
            float x = v[c * f->planes + k];
            out[c * n + k] =
                f->h.kind == SFIELD__KIND_SOURCE || f->h.logarithm ? x : (k ? 0 : 1 / sfield__y00) - x;
        }
}

/* Turns 16 positions in a field's space into planes about its center, in r. Positions that are not finite go
   to the center; the bits returned are those of the others. */
static uint32_t sfield__gather_positions(const sfield_field *f, const float *positions, size_t count,
                                         float *p)
{
    uint32_t good = 0, l, k;
    for (l = 0; l < SFIELD__LANES; l++) {
        const float *q = positions + 3 * (l < count ? l : 0);
        float d[3], size = 0;
        for (k = 0; k < 3; k++) {
            d[k] = (q[k] - f->h.center[k]) / f->h.radius;
            size += fabsf(d[k]);
        }
        if (sfield__finite(size) && size < 1e15f) good |= 1u << l;
        for (k = 0; k < 3; k++) p[k * SFIELD__LANES + l] = good >> l & 1 ? d[k] : 0;
    }
    return good;
}

/* Checks what the queries of this name are given. occlusion: not 0 if only visibility will do. */
static sfield_result sfield__check_query(const sfield_field *f, const char *function, const float *positions,
                                         const float *out, int occlusion)
{
    const sfield__logger log = sfield__logger_for(&f->log, function);
    if (!positions || !out) return sfield__fail_null(&log, positions ? "out" : "positions");
    if (f->h.kind == SFIELD__KIND_SELF)
        return sfield__fail(&log, SFIELD_ERR_MISMATCH, "field", "is a self-visibility");
    if (occlusion && f->h.kind != SFIELD__KIND_OCCLUSION)
        return sfield__fail(&log, SFIELD_ERR_MISMATCH, "field", "is a source, not an occlusion field");
    if (occlusion && f->h.logarithm)
        return sfield__fail(&log, SFIELD_ERR_MISMATCH, "field", "holds logarithms");
    if (f->h.shard_end)
        return sfield__fail(&log, SFIELD_ERR_MISMATCH, "field", "is a shard: sfield_merge first");
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_query(const sfield_field *f, size_t count, const float *positions, float time,
                                      float *out)
{
    float p[3 * SFIELD__LANES];
    sfield__place at;
    size_t i, size;
    uint32_t l, good, haar, n;
    sfield_result result;
    if (!f) return SFIELD_ERR_ARGUMENT;
    result = sfield__check_query(f, "sfield_query", positions, out, 0);
    if (result != SFIELD_OK) return result;
    haar = f->h.basis == SFIELD_BASIS_HAAR;
    size = (size_t)f->h.channels * (haar ? 6 * f->h.cube_side * f->h.cube_side : f->h.bands * f->h.bands);
    for (i = 0; i < count; i += SFIELD__LANES) {
        n = count - i < SFIELD__LANES ? (uint32_t)(count - i) : (uint32_t)SFIELD__LANES;
        good = sfield__gather_positions(f, positions + 3 * i, n, p);
        sfield__locate16(f, p, &at, 0);
        for (l = 0; l < n; l++) {
            float *o = out + (i + l) * size;
            size_t k;
            if (!(good >> l & 1)) {
                for (k = 0; k < size; k++) o[k] = haar && f->h.kind != SFIELD__KIND_SOURCE ? 1.0f : 0.0f;
                if (!haar && f->h.kind != SFIELD__KIND_SOURCE && !f->h.logarithm) o[0] = 1 / sfield__y00;
            }
#ifndef SFIELD_WITHOUT_WAVELETS
            else if (haar) sfield__query_haar(f, &at, (int)l, time, o);
#endif
            else sfield__query_sh(f, &at, (int)l, time, o);
        }
    }
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_ambient(const sfield_field *f, size_t count, const float *positions,
                                        float *out)
{
    float p[3 * SFIELD__LANES], first[16];
    sfield__place at;
    uint32_t l, n, good;
    size_t i;
    sfield_result result;
    if (!f) return SFIELD_ERR_ARGUMENT;
    result = sfield__check_query(f, "sfield_ambient", positions, out, 1);
    if (result != SFIELD_OK) return result;
    for (i = 0; i < count; i += n) {
        n = count - i < SFIELD__LANES ? (uint32_t)(count - i) : (uint32_t)SFIELD__LANES;
        good = sfield__gather_positions(f, positions + 3 * i, n, p);
        sfield__locate16(f, p, &at, 0);
        for (l = 0; l < n; l++) {
            float hidden = 0;
            if (f->h.basis == SFIELD_BASIS_SH) {
                sfield__fetch_lane(f, &at, (int)l, 0, 8, first, 0);
                hidden = first[0] * sfield__y00;
            }
#ifndef SFIELD_WITHOUT_WAVELETS
            else hidden = sfield__hidden_share(f, &at, (int)l);
#endif
            out[i + l] = good >> l & 1 ? (hidden < 1 ? (hidden > 0 ? 1 - hidden : 1.0f) : 0.0f) : 1.0f;
        }
    }
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_self(const sfield_field *f, size_t first, size_t count, float *out)
{
    uint32_t k, n;
    size_t i;
    sfield__logger log;
    if (!f) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_for(&f->log, "sfield_self");
    if (!out) return sfield__fail_null(&log, "out");
    if (f->h.kind != SFIELD__KIND_SELF)
        return sfield__fail(&log, SFIELD_ERR_MISMATCH, "field", "is not a self-visibility");
    if (!sfield__check_value(&log, first <= f->h.samples, "first", (double)first,
                             "at most the field's points") ||
        !sfield__check_value(&log, count <= f->h.samples - first, "count", (double)count,
                             "at most the field's points from `first` on"))
        return SFIELD_ERR_ARGUMENT;
    n = f->h.basis == SFIELD_BASIS_SH ? f->h.bands * f->h.bands : 6 * f->h.cube_side * f->h.cube_side;
    for (i = 0; i < count; i++) {
        float *o = out + i * n;
        if (f->h.basis == SFIELD_BASIS_SH) {
            for (k = 0; k < n; k++)
                o[k] = f->scale[k] * (float)f->sample[(first + i) * f->h.stride + k] + f->bias[k];
        }
#ifndef SFIELD_WITHOUT_WAVELETS
        else sfield__self_haar(f, first + i, o);
#endif
    }
    return SFIELD_OK;
}

/* ==== src/shadowfield/build_state.h ==== */

/* ---- building: what a build holds ---- */

enum { SFIELD__MOST_WIDTH = 512, SFIELD__EMISSIVE_WIDTH = 256, SFIELD__MOST_VIEWS = 256 };

typedef struct sfield__texels {     /* of a cube: tables */
    float *direction, *basis;       /* 3 floats; integrals of the basis, `planes` floats */
    float *angle;                   /* solid angle */
    float  node[64];                /* coordinates of the position grid */
} sfield__texels;

typedef struct sfield__view {       /* of one task */
    uint64_t *bits;                 /* 6 x width rows of width samples */
    float    *depth;                /* emissive meshes: 1 / distance and triangle + 1 of each sample */
    uint32_t *owner;
    uint8_t   touched[6 * SFIELD__MOST_WIDTH];      /* 1: something was drawn in this row */
    float    *texel, *haar, *key;   /* channels x 6 N^2; keys once */
    double   *work;                 /* logarithms */
    double    lost, total;          /* squares of wavelets */
    uint64_t  moved;
    uint32_t  width, scale;         /* samples a side of a face, of a texel */
} sfield__view;

typedef enum sfield__what {
    SFIELD__MESH, SFIELD__EMISSIVE, SFIELD__ANALYTIC, SFIELD__CALLBACK, SFIELD__SELF, SFIELD__VIEWS
} sfield__what;

typedef struct sfield__build {
    sfield__what      what;
    sfield__allocator allocator;
    sfield__logger    log;
    sfield_desc       desc;
    sfield__header    h;
    void             *held[24];
    uint32_t          held_count;
    size_t            bytes, peak;
    sfield_algebra   *algebra;      /* logarithms */
    float            *position;     /* of vertices, about the center, in r */
    uint32_t         *index, *original;
    float            *corner;       /* of triangles: planes of x, y, z of first corners, then of the others */
    size_t            vertices, triangles, corner_room;     /* room: from one plane to the next */
    sfield_mask_fn    mask_fn;      /* of the mesh, and what is given to it */
    void             *mask_user;
    const float      *radiance;     /* of triangles, this frame's */
    sfield_emitter    emitter;
    float             cosine;       /* of its cone */
    const sfield_points *points;
    float             offset, time;
    sfield__texels    texels;
    sfield__view     *view;
    uint32_t          pieces, planes, cells, most;     /* most: wavelets kept of a cube */
    float             window[SFIELD_MAX_BANDS];
    size_t            first, count; /* samples of this batch: a shell, or some points */
    size_t            from, to;     /* of them, those that tasks do now */
    sfield_views_fn   see;          /* VIEWS: and what it saw, `seen_size` floats an eye */
    void             *see_user;
    float            *eyes, *seen;
    uint8_t          *moved;        /* of each of them: taken outside the mesh */
    size_t            seen_size;
    float             radius;       /* of this shell */
    float             radii[64];
    float            *value;        /* SH: stride floats a sample of the batch */
    uint32_t         *kept, *entry; /* HAAR: number and `most` entries a sample of the batch */
    float            *kept_scale;
    sfield_field     *out;
    uint32_t         *all, all_used, all_room, *offsets;
    float            *scales;
    uint32_t          skipped;
    int               simd;         /* sfield__simd_level */
} sfield__build;

/* Allocates memory that lives as long as the build. If it returns NULL the caller has only to return: all
   that a build holds is freed at its end. */
static void *sfield__hold_memory(sfield__build *b, size_t count, size_t size)
{
    const int room = b->held_count < sizeof b->held / sizeof b->held[0];
    void *memory = room ? sfield__alloc_array(&b->allocator, count ? count : 1, size) : NULL;
    if (!memory) return NULL;
    b->held[b->held_count++] = memory;
    b->bytes += (count ? count : 1) * size;
    b->peak = b->bytes > b->peak ? b->bytes : b->peak;
    return memory;
}

static void sfield__release_build(sfield__build *b)
{
    while (b->held_count) sfield__free(&b->allocator, b->held[--b->held_count]);
    sfield__free(&b->allocator, b->all);
    sfield_algebra_free(b->algebra);
    sfield_free(b->out);
}

static int sfield__tell_progress(const sfield__build *b, float fraction)
{
    return !b->desc.system.progress || b->desc.system.progress(b->desc.system.user, fraction) == 0;
}

static void sfield__run_tasks(sfield__build *b, void (*task)(void *, size_t))
{
    size_t p;
    if (b->desc.system.parallel_for) b->desc.system.parallel_for(b->desc.system.user, b->pieces, task, b);
    else for (p = 0; p < b->pieces; p++) task(b, p);
}

/* Callbacks cannot be measured: the bounding sphere has to be given. */
static sfield_result sfield__need_radius(const sfield__build *b)
{
    return sfield__check_value(&b->log, b->desc.radius > 0, "desc.radius", (double)b->desc.radius,
                        "> 0 without a mesh")
               ? SFIELD_OK
               : SFIELD_ERR_DESC;
}

/* ==== src/shadowfield/build_desc.h ==== */

/* ---- building: a desc, checked, with its defaults ---- */

/* Returns whether enums, bands and sides of a desc are in range; if not, a line says so. */
static int sfield__check_sides(const sfield__logger *log, const sfield_desc *d, int haar)
{
    return sfield__check_value(log, (uint32_t)d->spacing < SFIELD_SPACING_COUNT, "desc.spacing",
                               (double)d->spacing, "0..2") &&
           sfield__check_value(log, d->bands <= SFIELD_MAX_BANDS, "desc.bands", d->bands, "0..8") &&
           sfield__check_value(log, !d->cube_side || sfield__is_side(d->cube_side, 4), "desc.cube_side",
                               d->cube_side, "0, 4, 8, 16, 32 or 64") &&
           sfield__check_value(log, d->shell_count != 1 && d->shell_count <= 64, "desc.shell_count",
                               d->shell_count, "0 or 2..64") &&
           sfield__check_value(log, d->position_side != 1 && d->position_side <= 64, "desc.position_side",
                               d->position_side, "0 or 2..64") &&
           sfield__check_value(log, sfield__in(d->keep, 0, 1), "desc.keep", (double)d->keep, "0..1") &&
           sfield__check_value(log, sfield__in(d->window, 0, 1e6f), "desc.window", (double)d->window,
                               "0..1e6") &&
           sfield__check_value(log, !haar || !d->logarithm, "desc.logarithm", d->logarithm, "0 for wavelets");
}

/* Returns whether what differs by the kind of field is in range; if not, a line says so. */
static int sfield__check_kind(const sfield__logger *log, const sfield_desc *d, sfield__kind kind)
{
    static const char *const centers[3] = { "desc.center[0]", "desc.center[1]", "desc.center[2]" };
    const uint32_t shells = (d->shell_count                       ? d->shell_count
                             : d->basis == SFIELD_BASIS_HAAR ? 32
                                                             : 16) *
                            (d->frame_count ? d->frame_count : 1);
    uint32_t i;
    for (i = 0; i < 3; i++)
        if (!sfield__check_value(log, sfield__in(d->center[i], -1e18f, 1e18f), centers[i],
                                 (double)d->center[i], "-1e18..1e18"))
            return 0;
    if (!sfield__check_value(log, !d->radii || d->shell_count, "desc.shell_count", 0,
                             "2..64 with desc.radii"))
        return 0;
    return sfield__check_value(log, d->radius == 0 || sfield__in(d->radius, 1e-18f, 1e18f), "desc.radius",
                               (double)d->radius, "0 or 1e-18..1e18") &&
           sfield__check_value(log, kind == SFIELD__KIND_OCCLUSION || !d->logarithm, "desc.logarithm",
                               d->logarithm, "0 but for occlusion") &&
           sfield__check_value(log, d->frame_count <= (kind == SFIELD__KIND_SOURCE ? 256u : 1u),
                               "desc.frame_count", d->frame_count, "0..256 for sources, else 0 or 1") &&
           sfield__check_value(log,
                               d->frames_per_second == 0 || sfield__in(d->frames_per_second, 1e-6f, 1e6f),
                               "desc.frames_per_second", (double)d->frames_per_second, "0 or 1e-6..1e6") &&
           sfield__check_value(log, kind == SFIELD__KIND_SELF || d->shard_end <= shells, "desc.shard_end",
                               d->shard_end, "at most all shells of all frames") &&
           sfield__check_value(log, !d->shard_end || kind != SFIELD__KIND_SELF, "desc.shard_end",
                               d->shard_end, "0 for self-visibility") &&
           sfield__check_value(log, d->shard_end ? d->shard_begin < d->shard_end : !d->shard_begin,
                               "desc.shard_begin", d->shard_begin, "below shard_end, or both 0");
}

/* Computes the radii of the shells. Returns 0 if there are no such shells. */
static int sfield__set_radii(sfield__build *b)
{
    sfield_desc *d = &b->desc;
    const float outer = d->outer != 0 ? d->outer : d->basis == SFIELD_BASIS_HAAR ? 20.0f : 8.0f;
    uint32_t i;
    d->inner = d->inner != 0 ? d->inner : 0.2f;
    if (!sfield__check_value(&b->log, sfield__in(d->inner, 1e-3f, 1000), "desc.inner", (double)d->inner,
                      "0 or 0.001..1000") ||
        !sfield__check_value(&b->log, sfield__in(outer, d->inner * 1.1f, 1000), "desc.outer", (double)outer,
                      "0 or 1.1 inner..1000"))
        return 0;
    for (i = 0; i < b->h.shells && d->radii; i++) {
        b->radii[i] = d->radii[i];
        if (!sfield__in(d->radii[i], 1e-3f, 1000) || (i && !(d->radii[i] > d->radii[i - 1] * 1.0002f))) {
            sfield__log_element(&b->log, "desc.radii", i, "is", (double)d->radii[i],
                                "0.001..1000 and 0.02 % above the one before");
            return 0;
        }
    }
    if (d->radii) return 1;
    for (i = 0; i < b->h.shells; i++) {
        float t = (float)i / (float)(b->h.shells - 1), ratio = outer / d->inner;
        b->radii[i] = b->h.spacing == SFIELD_SPACING_UNIFORM ? d->inner + t * (outer - d->inner)
                                                             : d->inner * sfield__pow(ratio, t);
        if (!sfield__check_value(&b->log, !i || b->radii[i] > b->radii[i - 1] * 1.0002f, "desc.shell_count",
                                 b->h.shells, "few enough for 0.02 % between two of them"))
            return 0;
    }
    if (b->h.shells) b->radii[b->h.shells - 1] = outer;
    return 1;
}

static sfield_result sfield__read_desc(sfield__build *b, const sfield_desc *desc, sfield__kind kind,
                                       const char *function)
{
    sfield_desc *d = &b->desc;
    sfield__header *h = &b->h;
    const int self = kind == SFIELD__KIND_SELF;
    float keep;
    uint32_t haar;
    memset(b, 0, sizeof *b);
    b->simd = sfield__simd_level();
    if (desc) *d = *desc;
    b->log = sfield__logger_of(&d->system, function);
    if (!sfield__system_good(&d->system)) return sfield__fail_allocator(&b->log);
    b->allocator = sfield__allocator_of(&d->system);
    haar = d->basis == SFIELD_BASIS_HAAR;
#ifdef SFIELD_WITHOUT_WAVELETS
    if (haar)
        return sfield__fail(&b->log, SFIELD_ERR_DESC, "desc.basis",
                            "is not in this header, joined without wavelets");
#endif
    if (!sfield__check_value(&b->log, (uint32_t)d->basis < SFIELD_BASIS_COUNT, "desc.basis", (double)d->basis,
                      "0..2") ||
        !sfield__check_sides(&b->log, d, haar != 0) || !sfield__check_kind(&b->log, d, kind))
        return SFIELD_ERR_DESC;
    h->magic = SFIELD__MAGIC;
    h->format = SFIELD__FORMAT;
    h->kind = kind;
    h->basis = haar ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH;
    h->logarithm = d->logarithm != 0;
    h->bands = haar ? 0 : d->bands ? d->bands : 4;
    h->cube_side = d->cube_side ? d->cube_side : haar ? 32 : 16;
    h->shells = self ? 0 : d->shell_count ? d->shell_count : haar ? 32 : 16;
    h->position_side = self ? 0 : d->position_side ? d->position_side : haar ? 32 : 16;
    h->spacing = d->spacing ? (uint32_t)d->spacing : (uint32_t)SFIELD_SPACING_GEOMETRIC;
    h->frames = d->frame_count ? d->frame_count : 1;
    h->frames_per_second = d->frames_per_second != 0 ? d->frames_per_second : 30;
    h->loop = d->loop != 0;
    h->channels = kind == SFIELD__KIND_SOURCE ? 3 : 1;
    h->window = d->window;
    h->radius = d->radius != 0 ? d->radius : 1;
    memcpy(h->center, d->center, sizeof h->center);
    b->planes = sfield__planes(h->bands);
    b->cells = 6 * h->cube_side * h->cube_side;
    h->stride = haar ? (h->channels == 3 ? 2u : 1u) : h->channels * b->planes;
    h->samples = self ? 1 : h->frames * h->shells * 6 * h->position_side * h->position_side;
    h->shard_begin = d->shard_begin;
    h->shard_end = d->shard_end;
    keep = d->keep != 0 ? d->keep : 0.01f;
    b->most = (uint32_t)(keep * (float)b->cells);
    b->most = b->most < 1 ? 1 : b->most;
    if (!sfield__set_radii(b)) return SFIELD_ERR_DESC;
    sfield_sh_window(h->bands, h->window, b->window);
    return SFIELD_OK;
}

/* ==== src/shadowfield/build_tubes.h ==== */

/* ---- building: what lines and cylinders radiate ---- */

/* A tube, a line or the side of a cylinder, as an eye sees it, in r. */
typedef struct sfield__tube {
    sfield__v3 axis, toward, across; /* unit: along the tube; from the eye to its axis by the shortest way;
                                        the cross product of both */
    float length, size;             /* half its length; the radius of a cylinder, 0 of a line */
    float along, away;              /* of the eye, from the middle along the axis, and from the axis */
    float sine[8 * 64 + 1];         /* edges of slices through the eye, across the axis: of their angles above
                                       the shortest way */
} sfield__tube;

static int sfield__is_tube(const sfield_emitter *e)
{
    return e->kind == SFIELD_EMITTER_LINE || e->kind == SFIELD_EMITTER_CYLINDER;
}

static sfield__v3 sfield__weigh2(sfield__v3 a, float s, sfield__v3 b, float t)
{
    return sfield__v3_add(sfield__v3_scale(a, s), sfield__v3_scale(b, t));
}

/* Looks at the emitter from the eye. A texel is four slices wide where the slices are widest. */
static void sfield__face_tube(const sfield__build *b, const float *eye, sfield__tube *t)
{
    const sfield_emitter *e = &b->emitter;
    const float inverse = 1 / b->h.radius;
    const uint32_t count = 8 * b->h.cube_side;
    sfield__v3 u = sfield__v3_scale(sfield__v3_load(e->u), inverse), at = sfield__v3_load(eye), shortest;
    float cosine;
    uint32_t i;
    t->axis = sfield__v3_normalize(u);
    t->length = sfield__v3_length(u);
    t->size = e->kind == SFIELD_EMITTER_CYLINDER ? e->radius * inverse : 0;
    t->along = sfield__v3_dot(at, t->axis);
    shortest = sfield__weigh2(t->axis, t->along, at, -1);
    t->away = sfield__v3_length(shortest);
    if (!(t->away > 1e-6f)) {           /* on the axis: any way will do */
        shortest = fabsf(t->axis.x) < 0.7f ? sfield__v3_make(1, 0, 0) : sfield__v3_make(0, 1, 0);
        shortest = sfield__weigh2(shortest, 1, t->axis, -sfield__v3_dot(shortest, t->axis));
    }
    t->toward = sfield__v3_normalize(shortest);
    t->across = sfield__v3_cross(t->axis, t->toward);
    for (i = 0; i <= count; i++)
        sfield__sincos(3.14159265f * ((float)i / (float)count - 0.5f), &t->sine[i], &cosine);
}

static int sfield__leaves_cone(const sfield__build *b, const float *d)
{
    const float *n = b->emitter.normal;
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) return 0;
    return -(n[0] * d[0] + n[1] * d[1] + n[2] * d[2]) < b->cosine;
}

/* Adds a share of light to the four texels about a direction, so that its middle stays where it is: one texel
   alone would move thin tubes by half a texel. */
static void sfield__spread_light(const sfield__build *b, sfield__view *v, const float *d, float share)
{
    const uint32_t n = b->h.cube_side, face = sfield__face_of(d);
    uint32_t at[2], i;
    float q[3], part[2];
    sfield__to_face(face, d, q);
    for (i = 0; i < 2; i++) {
        float x = (q[i] / q[2] + 1) * 0.5f * (float)n - 0.5f;
        x = x > 0 ? x : 0;
        at[i] = (uint32_t)x < n - 2 ? (uint32_t)x : n - 2;
        part[i] = x - (float)at[i] < 1 ? x - (float)at[i] : 1;
    }
    for (i = 0; i < 4; i++) {
        const float x = i & 1 ? part[0] : 1 - part[0], y = i & 2 ? part[1] : 1 - part[1];
        v->texel[sfield__texel_number(n, face, at[0] + (i & 1), at[1] + (i >> 1))] += share * x * y;
    }
}

/* Adds what lies in a strip along the tube: turned about the axis by an angle of this sine and cosine from
   the shortest way, so far from the eye, and so wide an angle. Between two slices it fills a solid angle of
   width times the difference of their sines. */
static void sfield__add_strip(const sfield__build *b, sfield__view *v, const sfield__tube *t, float sine,
                              float cosine, float distance, float width)
{
    const float low = -t->length - t->along, high = t->length - t->along;
    const float first = low / sqrtf(low * low + distance * distance);
    const float last = high / sqrtf(high * high + distance * distance);
    const sfield__v3 out = sfield__weigh2(t->toward, cosine, t->across, sine);
    uint32_t i;
    for (i = 0; i < 8 * b->h.cube_side; i++) {
        const float from = t->sine[i] > first ? t->sine[i] : first;
        const float to = t->sine[i + 1] < last ? t->sine[i + 1] : last;
        const float middle = 0.5f * (from + to);
        float d[3];
        if (!(from < to)) continue;
        sfield__v3_store(d, sfield__weigh2(out, sqrtf(1 - middle * middle), t->axis, middle));
        if (!sfield__leaves_cone(b, d)) sfield__spread_light(b, v, d, (to - from) * width);
    }
}

/* Adds the strips of a cylinder that face an eye outside. They are even about its axis, so that their
   distance is smooth up to the edge of the cylinder. */
static void sfield__add_strips(const sfield__build *b, sfield__view *v, const sfield__tube *t)
{
    const float ratio = t->size / t->away, widest = sfield__asin(ratio);
    const uint32_t count = 8 + (uint32_t)(5.1f * widest * (float)b->h.cube_side);
    float before = -widest;
    uint32_t i;
    for (i = 0; i < count; i++) {
        const float step = 3.14159265f / (float)count, angle = step * ((float)i + 0.5f) - 1.57079633f;
        float s, c, edge, after;
        float sine, cosine, distance;
        sfield__sincos(angle, &s, &c);
        sfield__sincos(angle + 0.5f * step, &edge, &cosine);
        after = i + 1 < count ? sfield__asin(ratio * edge) : widest;
        sine = ratio * s;
        cosine = sqrtf(1 - sine * sine);
        distance = t->away * cosine - t->size * c;
        sfield__add_strip(b, v, t, sine, cosine, distance > 1e-6f ? distance : 1e-6f, after - before);
        before = after;
    }
}

/* Samples a line or cylinder. A line is a cylinder that became thin as its radiance rose, so that radiance
   times diameter stayed: from h away that is a strip as wide as the diameter over h. Nearer than half the way
   to the next sample point it does not grow, for fields are interpolated. */
static void sfield__sample_tube(const sfield__build *b, sfield__view *v, const float *eye)
{
    const float *radiance = b->emitter.radiance;
    sfield__tube t;
    uint32_t i, c;
    sfield__face_tube(b, eye, &t);
    if (b->emitter.kind == SFIELD_EMITTER_LINE) {
        const float apart = 1.57079633f / (float)(b->h.position_side - 1);
        const float least = 0.5f * apart * sfield__v3_length(sfield__v3_load(eye));
        const float h = t.away > least ? t.away : least;
        sfield__add_strip(b, v, &t, 0, 1, h, 1 / (h * b->h.radius));
    } else if (t.away > t.size) sfield__add_strips(b, v, &t);
    else if (fabsf(t.along) <= t.length)        /* inside: as inside a sphere */
        for (i = 0; i < b->cells; i++)
            if (!sfield__leaves_cone(b, b->texels.direction + 3 * i)) v->texel[i] = b->texels.angle[i];
    for (i = 0; i < b->cells; i++) {
        const float bright = v->texel[i] / b->texels.angle[i];
        for (c = 0; c < 3; c++) {
            const float x = bright * radiance[c];
            v->texel[c * b->cells + i] = x < 1e18f ? x : 1e18f;
        }
    }
}

/* ==== src/shadowfield/build_emitters.h ==== */

/* ---- building: what analytic lights and callbacks radiate ---- */

/* Writes what an analytic emitter radiates to the eye (in r, about the center) from a direction. */
static void sfield__sample_emitter(const sfield__build *b, const float *eye, const float *d, float *rgb)
{
    const sfield_emitter *e = &b->emitter;
    float r = b->h.radius, along = eye[0] * d[0] + eye[1] * d[1] + eye[2] * d[2], facing, t;
    float d2 = eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2], size = e->radius / r;
    uint32_t c;
    rgb[0] = rgb[1] = rgb[2] = 0;
    facing = -(e->normal[0] * d[0] + e->normal[1] * d[1] + e->normal[2] * d[2]);
    if (e->kind == SFIELD_EMITTER_CALLBACK) {
        float p[3];
        for (c = 0; c < 3; c++) p[c] = b->h.center[c] + r * eye[c];
        if (e->view_fn) e->view_fn(e->user, b->time, p, d, rgb);
        for (c = 0; c < 3; c++) {
            if (!(sfield__finite(rgb[c]) && rgb[c] > 0)) rgb[c] = 0;
            rgb[c] = rgb[c] < 1e18f ? rgb[c] : 1e18f;
        }
        return;
    }
    if (e->kind == SFIELD_EMITTER_SPHERE) {
        if (d2 > size * size && (along > 0 || d2 - along * along > size * size)) return;
        if ((e->normal[0] != 0 || e->normal[1] != 0 || e->normal[2] != 0) && facing < b->cosine) return;
    } else {
        const float unit = sfield__unit(r);
        float p[3], n[3], nl;
        sfield__v3 u = sfield__v3_scale(sfield__v3_load(e->u), unit),
                   w = sfield__v3_scale(sfield__v3_load(e->v), unit);
        sfield__v3 cross = sfield__v3_cross(u, w);
        if (e->kind == SFIELD_EMITTER_RECTANGLE) sfield__v3_store(n, sfield__v3_normalize(cross));
        else memcpy(n, e->normal, sizeof n);
        nl = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
        t = -(n[0] * eye[0] + n[1] * eye[1] + n[2] * eye[2]) / (nl < 0 ? nl : -1e-30f);
        if (!(nl < 0) || !(t > 0) || !(t < 1e6f) || -nl < b->cosine) return;
        for (c = 0; c < 3; c++) p[c] = (eye[c] + t * d[c]) * r;
        if (e->kind == SFIELD_EMITTER_DISC) {
            if (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] > e->radius * e->radius) return;
        } else {
            sfield__v3 q = sfield__v3_scale(sfield__v3_load(p), unit);
            float uu = sfield__v3_dot(u, u), vv = sfield__v3_dot(w, w), uv = sfield__v3_dot(u, w);
            float pu = sfield__v3_dot(q, u), pv = sfield__v3_dot(q, w), det = uu * vv - uv * uv;
            if (fabsf(pu * vv - pv * uv) > det || fabsf(pv * uu - pu * uv) > det) return;
        }
    }
    memcpy(rgb, e->radiance, 3 * sizeof *rgb);
}

/* Samples analytic lights and callbacks, in those texels that the bounding sphere reaches. */
static void sfield__sample_cube(const sfield__build *b, sfield__view *v, const float *eye)
{
    uint32_t i, x, y;
    uint32_t c, face, tx;
    uint32_t ty, s = v->scale, n = b->h.cube_side;
    float d = sqrtf(eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2]);
    float reach = d > 1.0001f ? sqrtf(1 - 1 / (d * d)) : -1, texel = 1.5f / (float)n;
    if (sfield__is_tube(&b->emitter)) {
        sfield__sample_tube(b, v, eye);
        return;
    }
    for (i = 0; i < b->cells; i++) {
        const float *to = b->texels.direction + 3 * i;
        float sum[3] = { 0, 0, 0 },
              cosine = d > 0 ? -(to[0] * eye[0] + to[1] * eye[1] + to[2] * eye[2]) / d : 1;
        /* cos(a - b) <= cos a + b: a texel's half diagonal is below 1.5 / N */
        if (cosine + texel < reach) continue;
        sfield__texel_place(n, i, &face, &tx, &ty);
        for (y = 0; y < s; y++)
            for (x = 0; x < s; x++) {
                double q[3], l;
                float dir[3], rgb[3];
                sfield__from_face(face, (2.0 * (tx * s + x) + 1) / (n * s) - 1,
                                  (2.0 * (ty * s + y) + 1) / (n * s) - 1, q);
                l = 1 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
                for (c = 0; c < 3; c++) dir[c] = (float)(q[c] * l);
                sfield__sample_emitter(b, eye, dir, rgb);
                for (c = 0; c < b->h.channels; c++) sum[c] += rgb[c];
            }
        for (c = 0; c < b->h.channels; c++) v->texel[c * b->cells + i] = sum[c] / (float)(s * s);
    }
}

/* Returns the radius of the sphere about an emitter's centre that holds it; 0 if the emitter has no area, or
   no length. */
static float sfield__emitter_radius(const sfield_emitter *e)
{
    const sfield__v3 u = sfield__v3_load(e->u), v = sfield__v3_load(e->v);
    float x, y;
    if (sfield__is_tube(e)) {
        const float size = e->kind == SFIELD_EMITTER_LINE ? 0 : e->radius;
        x = sfield__v3_length(u);
        if (!(x > 0) || (e->kind == SFIELD_EMITTER_CYLINDER && !(size >= 1e-17f))) return 0;
        return sqrtf(x * x + size * size);
    }
    if (e->kind != SFIELD_EMITTER_RECTANGLE) return e->radius;
    x = sfield__v3_length(sfield__v3_add(u, v));
    y = sfield__v3_length(sfield__v3_sub(u, v));
    if (!(sfield__v3_length(sfield__v3_normalize(sfield__v3_cross(u, v))) > 0)) return 0;
    return x > y ? x : y;               /* of a side that is not finite neither: refused */
}

/* Takes the emitter's settings and, where it is to be fitted, the radius of the bounding sphere. */
static sfield_result sfield__take_emitter(sfield__build *b)
{
    static const char *const radiances[3] = { "emitter.radiance[0]", "emitter.radiance[1]",
                                              "emitter.radiance[2]" };
    sfield_emitter *e = &b->emitter;
    const int unit = sfield__unit_vector(e->normal),
              zero = e->normal[0] == 0 && e->normal[1] == 0 && e->normal[2] == 0;
    const char *shape = e->kind == SFIELD_EMITTER_RECTANGLE ? "half the diagonal of emitter.u and v"
                        : e->kind == SFIELD_EMITTER_LINE    ? "the length of emitter.u"
                        : sfield__is_tube(e)                ? "the sphere about emitter.u and radius"
                                                            : "emitter.radius";
    float fit, sine;
    uint32_t i;
    if (!sfield__check_value(&b->log, (uint32_t)e->kind < SFIELD_EMITTER_COUNT, "emitter.kind",
                             (double)e->kind, "0..6"))
        return SFIELD_ERR_DESC;
    if (e->kind == SFIELD_EMITTER_DEFAULT) e->kind = SFIELD_EMITTER_SPHERE;
    for (i = 0; i < 3; i++)
        if (!sfield__check_value(&b->log, sfield__in(e->radiance[i], 0, 1e18f), radiances[i],
                                 (double)e->radiance[i], "0..1e18"))
            return SFIELD_ERR_DESC;
    if (unit < 1 && (!zero || e->kind == SFIELD_EMITTER_DISC))
        return sfield__fail(&b->log, SFIELD_ERR_DESC, "emitter.normal", "is not unit");
    if (!sfield__check_value(&b->log, sfield__in(e->cone_half_angle, 0, 3.14159274f),
                             "emitter.cone_half_angle", (double)e->cone_half_angle, "0..pi"))
        return SFIELD_ERR_DESC;
    b->cosine = 0;
    if (e->cone_half_angle > 0) sfield__sincos(e->cone_half_angle, &sine, &b->cosine);
    if (e->kind == SFIELD_EMITTER_CALLBACK) {
        if (!e->view_fn) return sfield__fail(&b->log, SFIELD_ERR_DESC, "emitter.view_fn", "is NULL");
        return sfield__need_radius(b);
    }
    fit = sfield__emitter_radius(e);
    if (!sfield__check_value(&b->log, sfield__in(fit, 1e-17f, 1e17f), shape, (double)fit, "1e-17..1e17"))
        return SFIELD_ERR_DESC;
    if (b->desc.radius == 0) b->h.radius = fit;
    if (!sfield__check_value(&b->log, b->h.radius >= fit * 0.999f, "desc.radius", (double)b->h.radius,
                      "0, or hold the emitter"))
        return SFIELD_ERR_DESC;
    return SFIELD_OK;
}

/* ==== src/shadowfield/build_views.h ==== */

/* ---- building: what is seen of a mesh from a sample point ---- */

/* Sets the bits of samples x0 to x1 of a row. */
SFIELD__INLINE void sfield__set_bits(uint64_t *row, int x0, int x1)
{
    int a = x0 >> 6, b = x1 >> 6, w;
    uint64_t first = ~(uint64_t)0 << (x0 & 63), last = ~(uint64_t)0 >> (63 - (x1 & 63));
    if (a == b) row[a] |= first & last;
    else {
        row[a] |= first;
        for (w = a + 1; w < b; w++) row[w] = ~(uint64_t)0;
        row[b] |= last;
    }
}

/* Draws the samples x0 to x1 of a row that are nearer than what was drawn before; of equally near ones the
   triangle that comes first in the mesh is kept, whatever is drawn first. plane: four floats, 16 apart, see
   sfield__store_planes; owner: the triangle + 1, and the topmost bit for the side that does not emit. */
static void sfield__draw_span(sfield__view *v, size_t row, int x0, int x1, const float *plane, uint32_t owner)
{
    const float half = 0.5f * (float)v->width, t = ((float)(row & (v->width - 1)) + 0.5f) / half - 1;
    float *depth = v->depth + row * v->width;
    uint32_t *drawn = v->owner + row * v->width;
    int x;
    for (x = x0; x <= x1; x++) {
        float close = (plane[0] * (((float)x + 0.5f) / half - 1) + plane[16] * t + plane[32]) / plane[48];
        if (close > depth[x] ||
            (close == depth[x] && (owner & 0x7fffffffu) < (drawn[x] & 0x7fffffffu))) {
            depth[x] = close;
            drawn[x] = owner;
        }
    }
}

/* Draws the samples x0 to x1 of a row as sfield__draw_span or sfield__set_bits does, but for those in holes
   of the mesh's mask. corners: of the triangle, nine floats, 16 apart: x, y and depth of each on the face. */
static void sfield__draw_masked_span(const sfield__build *b, sfield__view *v, size_t row, int x0, int x1,
                                     const float *plane, uint32_t owner, const float *corners)
{
    const double half = 0.5 * (double)v->width;
    const double t = ((double)(row & (v->width - 1)) + 0.5) / half - 1;
    double c[9];
    float weights[3];
    int x;
    for (x = 0; x < 9; x++) c[x] = (double)corners[16 * x];
    for (x = x0; x <= x1; x++) {
        sfield__mask_weights(c, ((double)x + 0.5) / half - 1, t, weights);
        if (!b->mask_fn(b->mask_user, (owner & 0x7fffffffu) - 1, weights)) continue;
        if (v->depth) sfield__draw_span(v, row, x, x, plane, owner);
        else sfield__set_bits(v->bits + row * (v->width / 64), x, x);
    }
}

/* Draws all triangles of the mesh that an eye sees, sixteen at a time, in any order. */
static void sfield__draw_triangles16(const sfield__build *b, sfield__view *v, const float *eye);

/* Counts the samples of texels in a column of s words, of which each holds a row of 64 / s texels. Neighbours
   are counted apart, so that each sum has the room of two texels. */
static void sfield__count_column(const uint64_t *row, size_t words, uint32_t s, uint32_t *count)
{
    const uint64_t ones = 0x5555555555555555u, twos = 0x3333333333333333u, fours = 0x0f0f0f0f0f0f0f0fu;
    const uint64_t keep = s == 1 ? ones : s == 2 ? twos : s == 4 ? fours : 0x00ff00ff00ff00ffu;
    const uint32_t field = s < 8 ? s : 8;
    uint64_t even = 0, odd = 0;
    uint32_t k;
    for (k = 0; k < s; k++, row += words) {
        uint64_t x = *row;
        if (s > 1) x -= x >> 1 & ones;
        if (s > 2) x = (x & twos) + (x >> 2 & twos);
        if (s > 4) x = (x + (x >> 4)) & fours;
        even += x & keep;
        odd += x >> field & keep;
    }
    if (s <= 8) {
        for (k = 0; k < 64 / s; k += 2) {
            count[k] = (uint32_t)(even >> k * s & (((uint64_t)1 << 2 * s) - 1));
            count[k + 1] = (uint32_t)(odd >> k * s & (((uint64_t)1 << 2 * s) - 1));
        }
        return;
    }
    even += odd;
    for (k = 16; k < s; k *= 2) even += even >> k;
    for (k = 0; k < 64 / s; k++) count[k] = (uint32_t)(even >> k * s & 0xffffu);
}

/* Adds the bits of a row of texels up, and clears them. */
static void sfield__count_bits(const sfield__build *b, sfield__view *v, uint32_t face, uint32_t y)
{
    const uint32_t n = b->h.cube_side, s = v->scale, words = v->width / 64;
    const float share = 1 / (float)(s * s);         /* a power of two */
    uint64_t *row = v->bits + (size_t)(face * v->width + y * s) * words;
    float *texel = v->texel + sfield__texel_number(n, face, 0, y);
    uint32_t w, k, at = 0, count[64];
    for (w = 0; w < words; w++) {
        sfield__count_column(row + w, words, s, count);
        for (k = 0; k < 64 / s; k++) {
            texel[at] = (float)count[k] * share;
            at = (at - 0x555u) & 0x555u;            /* the next one along x, in Morton order */
        }
    }
    memset(row, 0, (size_t)s * words * sizeof *row);
}

/* Adds the radiance seen in a row of samples to texels, and clears the row. */
static void sfield__count_radiance(const sfield__build *b, sfield__view *v, uint32_t face, uint32_t y)
{
    const uint32_t n = b->h.cube_side, s = v->scale;
    const size_t row = (size_t)(face * v->width + y) * v->width;
    const float share = 1 / (float)(s * s);
    uint32_t x, c;
    for (x = 0; x < v->width; x++) {
        const uint32_t owner = v->owner[row + x];
        if (!owner) continue;
        if (owner >> 31 == 0) {
            float *texel = v->texel + sfield__texel_number(n, face, x / s, y / s);
            const float *radiance = b->radiance + 3 * (size_t)(owner - 1);
            for (c = 0; c < 3; c++) texel[c * b->cells] += radiance[c] * share;
        }
        v->depth[row + x] = 0;
        v->owner[row + x] = 0;
    }
}

/* Adds the drawn samples up to texels, and clears the buffers. */
static void sfield__count_samples(const sfield__build *b, sfield__view *v)
{
    const uint32_t n = b->h.cube_side, s = v->scale;
    uint32_t face, y, k;
    for (face = 0; face < 6; face++)
        for (y = 0; y < n; y++) {
            uint8_t *touched = v->touched + face * v->width + y * s;
            if (!memchr(touched, 1, s)) continue;
            for (k = 0; k < s && v->depth; k++)
                if (touched[k]) sfield__count_radiance(b, v, face, y * s + k);
            if (!v->depth) sfield__count_bits(b, v, face, y);
            memset(touched, 0, s);
        }
}

/* Fills the texels of one sample: alpha, or three channels of radiance. */
static void sfield__view_from(const sfield__build *b, sfield__view *v, const float *eye)
{
    float d = sqrtf(eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2]);
    uint32_t most = b->what == SFIELD__EMISSIVE ? SFIELD__EMISSIVE_WIDTH : SFIELD__MOST_WIDTH, c;
    memset(v->texel, 0, (size_t)b->h.channels * b->cells * sizeof *v->texel);
    /* A word of 64 bits holds a row of a texel's samples. */
    if (most > 64 * b->h.cube_side) most = 64 * b->h.cube_side;
    for (v->width = 64; v->width < most && ((float)v->width < 24 * d || v->width < 2 * b->h.cube_side);)
        v->width *= 2;
    if (b->what == SFIELD__SELF) v->width = b->h.cube_side < 32 ? 64 : 2 * b->h.cube_side;
    v->scale = v->width / b->h.cube_side;
    if (b->what == SFIELD__ANALYTIC || b->what == SFIELD__CALLBACK) {
        sfield__sample_cube(b, v, eye);
        for (c = 0; c < b->cells && b->what == SFIELD__CALLBACK; c++)
            v->texel[c] = v->texel[c] < 1 ? v->texel[c] : 1;
        return;
    }
    sfield__draw_triangles16(b, v, eye);
    sfield__count_samples(b, v);
}

/* ==== src/shadowfield/build_inside.h ==== */

/* ---- building: sample points inside a mesh ---- */

/* Fields are interpolated: a position inside the mesh, which sees nothing, would darken receivers between it
   and the next one outside. It takes the view from the surface instead, that of a receiver there. */

enum { SFIELD__INSIDE_RAYS = 27, SFIELD__CROSSINGS = 32 };
static const float sfield__outside = 1e-3f;     /* over the surface, in r; gaps below twice that are none */

typedef struct sfield__inside_ray {        /* a ray from the eye */
    float d[3];
    uint32_t face;                  /* of the cube about the eye that it goes through */
    float at[SFIELD__CROSSINGS];    /* where it meets the mesh, rising; < 0: goes in at that distance, > 0:
                                       comes out */
    int   count;                    /* of them; those beyond the last are left out */
    int   winding;                  /* times that it comes out, less times that it goes in */
} sfield__inside_ray;

/* Aims the rays: outwards, and to faces, edges and corners of a cube. All are turned a little, so that none
   runs along the edges of a mesh. */
static void sfield__aim_rays(const float *eye, sfield__inside_ray *ray)
{
    int i;
    for (i = 0; i < SFIELD__INSIDE_RAYS; i++) {
        sfield__v3 d = sfield__v3_make((float)(i % 3 - 1), (float)(i / 3 % 3 - 1), (float)(i / 9 - 1));
        if (i == SFIELD__INSIDE_RAYS / 2) d = sfield__v3_load(eye);
        d = sfield__v3_add(sfield__v3_normalize(d), sfield__v3_make(0.0131f, -0.0079f, 0.0107f));
        sfield__v3_store(ray[i].d, sfield__v3_normalize(d));
        ray[i].face = sfield__face_of(ray[i].d);
        ray[i].count = ray[i].winding = 0;
    }
}

static void sfield__add_crossing(sfield__inside_ray *ray, float t, int out)
{
    int i = ray->count < SFIELD__CROSSINGS ? ray->count++ : SFIELD__CROSSINGS;
    ray->winding += out ? 1 : -1;
    for (; i > 0 && fabsf(ray->at[i - 1]) > t; i--)
        if (i < SFIELD__CROSSINGS) ray->at[i] = ray->at[i - 1];
    if (i < SFIELD__CROSSINGS) ray->at[i] = out ? t : -t;
}

/* Finds where all rays from the eye meet the mesh, triangle after triangle. */
static void sfield__find_crossings16(const sfield__build *b, const float *eye, sfield__inside_ray *ray);

/* Returns the distance at which a ray that starts inside is out of everything; 0 if there is none. */
static float sfield__find_way_out(const sfield__inside_ray *ray)
{
    int i, inside = ray->winding;
    for (i = 0; i < ray->count && inside > 0; i++) {
        inside += ray->at[i] < 0 ? 1 : -1;
        if (inside <= 0 && i + 1 < SFIELD__CROSSINGS &&
            (i + 1 == ray->count || fabsf(ray->at[i + 1]) > ray->at[i] + 2 * sfield__outside))
            return ray->at[i];
    }
    return 0;
}

static float sfield__share_hidden(const sfield__build *b, const float *texel)
{
    float sum = 0;
    uint32_t c;
    for (c = 0; c < b->cells; c++) sum += texel[c];
    return sum / (float)b->cells;
}

/* Moves the eye out of the mesh. Returns 0 if the eye is not inside. It is inside if nearly all directions
   are hidden and most rays leave the mesh once more than they enter it, counter-clockwise triangles being
   seen from outside. So nothing is inside a single sheet, a room or a cup. */
static int sfield__move_out(const sfield__build *b, float hidden, float *eye)
{
    sfield__inside_ray ray[SFIELD__INSIDE_RAYS];
    float nearest = 0;
    int i, k, inside = 0, best = 0;
    if (hidden < 0.99f) return 0;
    sfield__aim_rays(eye, ray);
    sfield__find_crossings16(b, eye, ray);
    for (i = 0; i < SFIELD__INSIDE_RAYS; i++) {
        float t = sfield__find_way_out(&ray[i]);
        inside += ray[i].winding > 0;
        if (!(t > 0 && t < 1000) || (nearest > 0 && t >= nearest)) continue;
        nearest = t;
        best = i;
    }
    if (2 * inside <= SFIELD__INSIDE_RAYS || !(nearest > 0)) return 0;
    for (k = 0; k < 3; k++) eye[k] += (nearest + sfield__outside) * ray[best].d[k];
    return 1;
}

/* Finds the eyes that are inside the mesh, by what was seen from them, and moves them out. */
static void sfield__find_inside_task(void *context, size_t piece)
{
    const sfield__build *b = (const sfield__build *)context;
    sfield__view *v = &b->view[piece];
    size_t i;
    for (i = piece; i < b->to - b->from; i += b->pieces) {
        const float *seen = b->seen + i * b->seen_size;
        float hidden = b->h.basis == SFIELD_BASIS_SH ? seen[0] / 3.54490770f : sfield__share_hidden(b, seen);
        b->moved[i] = 0;
        if (!(hidden >= 0.99f)) continue;
        b->moved[i] = (uint8_t)sfield__move_out(b, hidden, b->eyes + 3 * i);
        v->moved += b->moved[i];
    }
}

/* ==== src/shadowfield/build_mesh.h ==== */

/* ---- building: the mesh, its bounding sphere and its inscribed one ---- */

static const float *sfield__vertex(const sfield_mesh *m, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)(const void *)m->positions + i * stride);
}

static size_t sfield__mesh_corners(const sfield_mesh *m)
{
    return m->indices || m->indices16 ? m->index_count : m->vertex_count;
}

static uint32_t sfield__mesh_index(const sfield_mesh *m, size_t i)
{
    return m->indices ? m->indices[i] : m->indices16 ? m->indices16[i] : (uint32_t)i;
}

/* Checks counts, strides and indices. What is wrong goes to the log. */
static sfield_result sfield__check_mesh(const sfield__build *b, const sfield_mesh *m)
{
    const size_t corners = sfield__mesh_corners(m);
    const char *count = m->indices || m->indices16 ? "mesh.index_count" : "mesh.vertex_count";
    size_t i;
    if (!m->positions) return sfield__fail(&b->log, SFIELD_ERR_ARGUMENT, "mesh.positions", "is NULL");
    if (m->indices && m->indices16)
        return sfield__fail(&b->log, SFIELD_ERR_ARGUMENT, "mesh", "has indices and indices16");
    if (!sfield__check_value(&b->log, sfield__stride_valid(m->vertex_stride, 12), "mesh.vertex_stride",
                             (double)m->vertex_stride, "0, or a multiple of 4 of at least 12") ||
        !sfield__check_value(&b->log, corners && corners % 3 == 0, count, (double)corners,
                             "a multiple of 3, > 0"))
        return SFIELD_ERR_ARGUMENT;
    if (!sfield__check_value(&b->log, corners / 3 <= 0x7ffffffeu, count, (double)corners,
                             "3 (2^31 - 2) or less") ||
        !sfield__check_value(&b->log, m->vertex_count <= 0xffffffffu, "mesh.vertex_count",
                             (double)m->vertex_count, "below 2^32"))
        return SFIELD_ERR_LIMIT;
    for (i = 0; i < corners; i++) {
        const uint32_t index = sfield__mesh_index(m, i);
        if (index < m->vertex_count) continue;
        sfield__log_index(&b->log, "mesh", i, index, m->vertex_count);
        return SFIELD_ERR_INPUT;
    }
    return SFIELD_OK;
}

/* Keeps the triangles that can be used. Returns 0 if there is no memory. */
static int sfield__take_triangles(sfield__build *b, const sfield_mesh *m, size_t stride, size_t count)
{
    size_t t;
    b->index = (uint32_t *)sfield__hold_memory(b, 3 * count, sizeof *b->index);
    b->original = (uint32_t *)sfield__hold_memory(b, count, sizeof *b->original);
    if (!b->index || !b->original) return 0;
    for (t = 0; t < count; t++) {
        uint32_t i[3], k, good = 1;
        for (k = 0; k < 3; k++) {
            i[k] = sfield__mesh_index(m, 3 * t + k);
            if (good) {
                sfield__v3 p = sfield__v3_load(sfield__vertex(m, stride, i[k]));
                good = sfield__v3_finite(p) && fabsf(p.x) < 1e18f && fabsf(p.y) < 1e18f && fabsf(p.z) < 1e18f;
            }
        }
        for (k = 0; k < 3 && good; k++)
            good =
                memcmp(sfield__vertex(m, stride, i[k]), sfield__vertex(m, stride, i[(k + 1) % 3]), 12) != 0;
        if (!good) {
            b->skipped++;
            continue;
        }
        memcpy(b->index + 3 * b->triangles, i, sizeof i);
        b->original[b->triangles++] = (uint32_t)t;
    }
    return 1;
}

static void sfield__fit_sphere(sfield__build *b, const sfield_mesh *m, size_t stride)
{
    sfield__v3 low = sfield__v3_make(0, 0, 0), high = low, c;
    size_t i;
    float r2 = 0;
    for (i = 0; i < 3 * b->triangles; i++) {
        sfield__v3 p = sfield__v3_load(sfield__vertex(m, stride, b->index[i]));
        low = i ? sfield__v3_min(low, p) : p;
        high = i ? sfield__v3_max(high, p) : p;
    }
    c = sfield__v3_add(sfield__v3_scale(low, 0.5f), sfield__v3_scale(high, 0.5f));
    sfield__v3_store(b->h.center, c);
    for (i = 0; i < 3 * b->triangles; i++) {
        sfield__v3 p = sfield__v3_sub(sfield__v3_load(sfield__vertex(m, stride, b->index[i])), c);
        r2 = sfield__v3_dot(p, p) > r2 ? sfield__v3_dot(p, p) : r2;
    }
    b->h.radius = sqrtf(r2);
}

/* Returns whether the bounding sphere holds what is drawn, to a thousandth. Horizons, cones and the tail
   beyond the last shell rely on the sphere; fields of points have none of them. */
static int sfield__is_bounded(const sfield__build *b)
{
    size_t i;
    for (i = 0; i < 3 * b->triangles && b->h.kind != SFIELD__KIND_SELF; i++) {
        const sfield__v3 p = sfield__v3_load(b->position + 3 * (size_t)b->index[i]);
        if (sfield__v3_dot(p, p) * (0.999f * 0.999f) > 1) return 0;
    }
    return 1;
}

/* Puts the corners of all triangles into planes, for kernels. Returns 0 if there is no memory. */
static int sfield__take_corners(sfield__build *b)
{
    size_t t, k, c;
    b->corner_room = (b->triangles + 15) / 16 * 16;
    b->corner = (float *)sfield__hold_memory(b, b->corner_room, 9 * sizeof *b->corner);
    if (!b->corner) return 0;
    memset(b->corner, 0, 9 * b->corner_room * sizeof *b->corner);
    for (t = 0; t < b->triangles; t++)
        for (k = 0; k < 3; k++)
            for (c = 0; c < 3; c++)
                b->corner[(3 * k + c) * b->corner_room + t] =
                    b->position[3 * (size_t)b->index[3 * t + k] + c];
    return 1;
}

static sfield_result sfield__take_mesh(sfield__build *b, const sfield_mesh *m)
{
    const size_t stride = m->vertex_stride ? m->vertex_stride : 12;
    const sfield_result result = sfield__check_mesh(b, m);
    size_t i, k;
    if (result != SFIELD_OK) return result;
    if (!sfield__take_triangles(b, m, stride, sfield__mesh_corners(m) / 3)) return SFIELD_ERR_ALLOC;
    if (!b->triangles)
        return sfield__fail(&b->log, SFIELD_ERR_INPUT, "mesh", "has no triangle that can be used");
    if (b->desc.radius == 0) sfield__fit_sphere(b, m, stride);
    if (!sfield__check_value(&b->log, sfield__in(b->h.radius, 1e-18f, 1e18f), "the radius of mesh",
                      (double)b->h.radius, "1e-18..1e18"))
        return SFIELD_ERR_INPUT;
    b->mask_fn = m->mask_fn;
    b->mask_user = m->user;
    b->vertices = m->vertex_count;
    b->position = (float *)sfield__hold_memory(b, 3 * b->vertices, sizeof *b->position);
    if (!b->position) return SFIELD_ERR_ALLOC;
    for (i = 0; i < b->vertices; i++)
        for (k = 0; k < 3; k++) {
            float x = (sfield__vertex(m, stride, i)[k] - b->h.center[k]) / b->h.radius;
            b->position[3 * i + k] = sfield__finite(x) ? x : 0;
        }
    if (!sfield__is_bounded(b))
        return sfield__fail(&b->log, SFIELD_ERR_DESC, "desc.center and radius", "do not hold the mesh");
    return sfield__take_corners(b) ? SFIELD_OK : SFIELD_ERR_ALLOC;
}

/* Returns the distance from the origin to the nearest point of a triangle. */
static float sfield__measure_triangle(const float *const *corner)
{
    sfield__v3 p[3], n;
    float best = 3e38f, nn;
    int i, inside = 1;
    for (i = 0; i < 3; i++) p[i] = sfield__v3_load(corner[i]);
    n = sfield__v3_cross(sfield__v3_sub(p[1], p[0]), sfield__v3_sub(p[2], p[0]));
    nn = sfield__v3_dot(n, n);
    for (i = 0; i < 3; i++) {
        sfield__v3 a = p[i], e = sfield__v3_sub(p[(i + 1) % 3], a);
        float ee = sfield__v3_dot(e, e), t = ee > 0 ? -sfield__v3_dot(a, e) / ee : 0, d;
        t = t < 0 ? 0 : t > 1 ? 1 : t;
        d = sfield__v3_length(sfield__v3_madd(a, e, t));
        best = d < best ? d : best;
        inside = inside && sfield__v3_dot(sfield__v3_cross(e, sfield__v3_scale(a, -1)), n) >= 0;
    }
    return inside && nn > 0 ? fabsf(sfield__v3_dot(n, p[0])) / sqrtf(nn) : best;
}

/* Returns the radius of a sphere about the center that the mesh closes off: everything is hidden from there,
   and no triangle is nearer. 0 if there is none. */
static float sfield__find_inscribed(sfield__build *b)
{
    const float eye[3] = { 0, 0, 0 };
    float nearest = 1;
    size_t t;
    uint32_t i;
    sfield__view_from(b, &b->view[0], eye);
    for (i = 0; i < b->cells; i++)
        if (b->view[0].texel[i] < 1) return 0;
    for (t = 0; t < b->triangles; t++) {
        const float *c[3];
        float d;
        for (i = 0; i < 3; i++) c[i] = b->position + 3 * (size_t)b->index[3 * t + i];
        d = sfield__measure_triangle(c);
        nearest = d < nearest ? d : nearest;
    }
    return nearest * b->h.radius;
}

/* ==== src/shadowfield/wavelets_build.h ==== */

/* ---- wavelets: choosing and packing those that are kept ---- */

/* Returns the `rank`-th largest (0: the largest) of count values, which are put in another order. */
static float sfield__select_rank(float *a, uint32_t count, uint32_t rank)
{
    uint32_t low = 0, high = count - 1;
    while (low < high) {
        float pivot = a[(low + high) / 2];
        uint32_t i = low, j = high;
        for (;;) {
            float swap;
            while (a[i] > pivot) i++;
            while (a[j] < pivot) j--;
            if (i >= j) break;
            swap = a[i];
            a[i++] = a[j];
            a[j--] = swap;
        }
        if (rank <= j) high = j;
        else low = j + 1;
    }
    return a[rank];
}

/* Returns the weight of a wavelet for the choice: its side, that is the area times the height of a wavelet of
   norm 1 (Ng et al. 2003 call their choice area-weighted). */
static float sfield__weigh_wavelet(const sfield__build *b, const float *haar, uint32_t i)
{
    uint32_t in_face = i % (b->h.cube_side * b->h.cube_side), squares = 1, c;
    float most = 0, side = (float)b->h.cube_side;
    for (; 4 * squares <= in_face; squares *= 4) side *= 0.5f;
    for (c = 0; c < b->h.channels; c++) {
        float x = fabsf(haar[c * b->cells + i]);
        most = x > most ? x : most;
    }
    return most * side;
}

static uint32_t sfield__quantise_wavelet(float x, float scale)
{
    float q = scale > 0 ? x / scale : 0;
    return (uint32_t)(int32_t)(q + (q < 0 ? -0.5f : 0.5f)) & 0xffffu;
}

static void sfield__encode_haar(const sfield__build *b, sfield__view *v, uint32_t *kept, float *scale,
                                uint32_t *entry)
{
    uint32_t i, c, used = 0;
    uint32_t n = 0, equal;
    float threshold = 0, most = 0, *sorted = v->key + b->cells;
    for (c = 0; c < b->h.channels; c++)
        sfield__haar_cube(b->h.cube_side, v->texel + c * b->cells, v->haar + c * b->cells, b->simd);
    for (i = 0; i < b->cells; i++) {
        v->key[i] = sfield__weigh_wavelet(b, v->haar, i);
        if (v->key[i] > 0) sorted[used++] = v->key[i];
    }
    if (used > b->most) threshold = sfield__select_rank(sorted, used, b->most - 1);
    for (i = 0, equal = b->most; i < b->cells; i++) equal -= v->key[i] > threshold && equal;
    for (i = 0; i < b->cells; i++) {
        int keep = v->key[i] > threshold || (v->key[i] == threshold && threshold > 0 && equal > 0);
        if (keep && v->key[i] == threshold) equal--;
        for (c = 0; c < b->h.channels; c++) {
            float x = v->haar[c * b->cells + i];
            v->total += (double)x * (double)x;
            if (!keep) v->lost += (double)x * (double)x;
            else most = fabsf(x) > most ? fabsf(x) : most;
        }
        if (keep) sorted[n++] = (float)i;
    }
    *scale = most / 32767;
    *kept = n;
    for (i = 0; i < n; i++) {
        uint32_t at = (uint32_t)sorted[i];
        entry[0] = at << 16 | sfield__quantise_wavelet(v->haar[at], *scale);
        if (b->h.channels == 3)
            entry[1] = sfield__quantise_wavelet(v->haar[b->cells + at], *scale) << 16 |
                       sfield__quantise_wavelet(v->haar[2 * b->cells + at], *scale);
        entry += b->h.stride;
    }
}

/* Appends the wavelets of a batch to those of all. */
static sfield_result sfield__append_wavelets(sfield__build *b, size_t first)
{
    size_t i, n = 0;
    for (i = 0; i < b->count; i++) n += b->kept[i];
    if (n > 0xffffffffu - b->all_used) return SFIELD_ERR_LIMIT;
    /* Room is made for no wavelets too, so that there is a pointer to add 0 to. */
    if (!b->all || b->all_used + n > b->all_room) {
        uint64_t room = ((uint64_t)b->all_used + n) * 3 / 2 + 1024;
        uint32_t *grown;
        room = room < 0xffffffffu ? room : 0xffffffffu;
        if (room > SIZE_MAX / (4 * b->h.stride)) return SFIELD_ERR_LIMIT;
        grown = (uint32_t *)sfield__alloc_array(&b->allocator, (size_t)room, 4 * b->h.stride);
        if (!grown) return SFIELD_ERR_ALLOC;
        if (b->all) memcpy(grown, b->all, 4 * (size_t)b->all_used * b->h.stride);
        sfield__free(&b->allocator, b->all);
        b->all = grown;
        b->peak = b->bytes + 4 * (size_t)(room + b->all_room) * b->h.stride;
        b->all_room = (uint32_t)room;
    }
    for (i = 0; i < b->count; i++) {
        b->offsets[first + i] = b->all_used;
        b->scales[first + i] = b->kept_scale[i];
        memcpy(b->all + (size_t)b->all_used * b->h.stride, b->entry + i * b->most * b->h.stride,
               4 * (size_t)b->kept[i] * b->h.stride);
        b->all_used += b->kept[i];
    }
    b->offsets[first + b->count] = b->all_used;
    return SFIELD_OK;
}

/* Allocates room for the wavelets of a batch, and for the offsets and scales of all samples. */
static sfield_result sfield__hold_wavelets(sfield__build *b, size_t batch)
{
    b->kept = (uint32_t *)sfield__hold_memory(b, batch, sizeof *b->kept);
    b->kept_scale = (float *)sfield__hold_memory(b, batch, sizeof *b->kept_scale);
    b->entry = (uint32_t *)sfield__hold_memory(b, batch, 4 * (size_t)b->most * b->h.stride);
    b->offsets = (uint32_t *)sfield__hold_memory(b, (size_t)b->h.samples + 1, sizeof *b->offsets);
    b->scales = (float *)sfield__hold_memory(b, b->h.samples, sizeof *b->scales);
    if (!b->kept || !b->kept_scale || !b->entry || !b->offsets || !b->scales) return SFIELD_ERR_ALLOC;
    memset(b->offsets, 0, ((size_t)b->h.samples + 1) * sizeof *b->offsets);
    memset(b->scales, 0, (size_t)b->h.samples * sizeof *b->scales);
    return SFIELD_OK;
}

/* Makes the block of a field from the wavelets of all batches. */
static sfield_result sfield__finish_wavelets(sfield__build *b)
{
    sfield_result result;
    size_t i;
    b->h.entries = b->all_used;
    /* Samples behind those of the shard have no entries. */
    for (i = b->first + b->count; i < b->h.samples; i++) b->offsets[i + 1] = b->all_used;
    result = sfield__alloc_field(&b->allocator, &b->log, &b->h, &b->out);
    if (result != SFIELD_OK) return result;
    memcpy(b->out->words + SFIELD__HEADER + b->h.shells, b->offsets, 4 * ((size_t)b->h.samples + 1));
    memcpy(b->out->words + SFIELD__HEADER + b->h.shells + b->h.samples + 1, b->scales,
           4 * (size_t)b->h.samples);
    if (b->all_used)
        memcpy(b->out->words + b->out->word_count - (size_t)b->all_used * b->h.stride, b->all,
               4 * (size_t)b->all_used * b->h.stride);
    return SFIELD_OK;
}

/* ==== src/shadowfield/build_samples.h ==== */

/* ---- building: samples seen, projected, packed ---- */

/* Applies the window to a channel, and takes its logarithm if the desc asks for it. */
static void sfield__finish_channel(const sfield__build *b, sfield__view *v, float *out)
{
    uint32_t k, l;
    for (l = 0, k = 0; l < b->h.bands; l++)
        for (; k < (l + 1) * (l + 1); k++) out[k] *= b->window[l];
    if (!b->h.logarithm) return;
    for (k = 0; k < b->h.bands * b->h.bands; k++) out[k] = (k ? 0 : 1 / sfield__y00) - out[k];
    sfield__sh_log(b->algebra, out, out, v->work);
}

/* Projects texel[] on the basis, into n^2 values for each channel, `planes` apart. Self-visibility is the
   visible share times the cosine. */
static void sfield__encode_sh(const sfield__build *b, sfield__view *v, const float *normal, float *out)
{
    uint32_t i, k, c, l;
    memset(out, 0, b->h.stride * sizeof *out);
    for (c = 0; c < b->h.channels; c++, out += b->planes) {
        const float *texel = v->texel + c * b->cells;
        for (i = 0; i < b->cells; i++) {
            const float *y = b->texels.basis + (size_t)i * b->planes, *d = b->texels.direction + 3 * i;
            float a = texel[i];
            if (normal) {
                float cosine = normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2];
                a = cosine > 0 ? (1 - a) * cosine : 0;
            }
            if (a == 0) continue;
            for (k = 0; k < b->planes; k += 8)
                for (l = 0; l < 8; l++) out[k + l] += a * y[k + l];
        }
        sfield__finish_channel(b, v, out);
    }
}

/* Takes what the caller's renderer saw from sample i of the batch: coefficients, or texels to encode. */
static void sfield__encode_seen(const sfield__build *b, sfield__view *v, size_t i)
{
    const float most = b->h.kind == SFIELD__KIND_SOURCE ? 1e18f : 100;
    float *seen = b->seen + (i - b->from) * b->seen_size, *out;
    uint32_t c, n = b->h.bands * b->h.bands;
    size_t k;
    for (k = 0; k < b->seen_size; k++) seen[k] = sfield__in(seen[k], -most, most) ? seen[k] : 0;
#ifndef SFIELD_WITHOUT_WAVELETS
    if (b->h.basis == SFIELD_BASIS_HAAR) {
        memcpy(v->texel, seen, b->seen_size * sizeof *seen);
        sfield__encode_haar(b, v, &b->kept[i], &b->kept_scale[i], b->entry + i * b->most * b->h.stride);
        return;
    }
#endif
    out = b->value + i * b->h.stride;
    memset(out, 0, b->h.stride * sizeof *out);
    for (c = 0; c < b->h.channels; c++, out += b->planes) {
        memcpy(out, seen + c * n, n * sizeof *out);
        sfield__finish_channel(b, v, out);
    }
}

/* Writes where sample i of the current shell lies, in r. */
static void sfield__sample_point(const sfield__build *b, size_t i, float *eye)
{
    uint32_t side = b->h.position_side, k;
    double d[3], l;
    sfield__from_face((uint32_t)(i / ((size_t)side * side)), (double)b->texels.node[i % side],
                      (double)b->texels.node[i / side % side], d);
    l = (double)b->radius / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (k = 0; k < 3; k++) eye[k] = (float)(d[k] * l);
}

static void sfield__build_task(void *context, size_t piece)
{
    const sfield__build *b = (const sfield__build *)context;
    sfield__view *v = &b->view[piece];
    size_t i;
    uint32_t k;
    for (i = b->from + piece; i < b->to; i += b->pieces) {
        const float *normal = NULL;
        float eye[3];
        if (b->what == SFIELD__VIEWS) {
            sfield__encode_seen(b, v, i);
            continue;
        }
        if (b->what == SFIELD__SELF) {
            const float *p = sfield__row(b->points->positions, b->points->position_stride, b->first + i);
            normal = sfield__row(b->points->normals, b->points->normal_stride, b->first + i);
            for (k = 0; k < 3; k++) eye[k] = (p[k] + b->offset * normal[k] - b->h.center[k]) / b->h.radius;
        } else sfield__sample_point(b, i, eye);
        sfield__view_from(b, v, eye);
        if ((b->what == SFIELD__MESH || b->what == SFIELD__SELF) && !b->desc.keep_inside &&
            sfield__move_out(b, sfield__share_hidden(b, v->texel), eye)) {
            sfield__view_from(b, v, eye);
            v->moved++;
        }
#ifndef SFIELD_WITHOUT_WAVELETS
        if (b->h.basis == SFIELD_BASIS_HAAR) {
            sfield__encode_haar(b, v, &b->kept[i], &b->kept_scale[i], b->entry + i * b->most * b->h.stride);
            continue;
        }
#endif
        sfield__encode_sh(b, v, normal, b->value + i * b->h.stride);
    }
}

/* Packs each coefficient into 8 bits, scaled to its range in this shell. The error is at most range / 510
   (T77). */
static void sfield__quantise(sfield__build *b, size_t first, uint32_t group)
{
    sfield_field *f = b->out;
    float *scale = (float *)(void *)(f->words + SFIELD__HEADER + b->h.shells) + (size_t)group * b->h.stride;
    float *bias = scale + (size_t)sfield__groups(&b->h) * b->h.stride;
    uint8_t *sample = (uint8_t *)(f->words + f->word_count) + first * b->h.stride;
    size_t i, k;
    for (k = 0; k < b->h.stride; k++) {
        float low = b->value[k], high = b->value[k], inverse;
        for (i = 1; i < b->count; i++) {
            float x = b->value[i * b->h.stride + k];
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        scale[k] = (high - low) / 255;
        bias[k] = low;
        inverse = scale[k] > 0 ? 1 / scale[k] : 0;
        for (i = 0; i < b->count; i++) {
            float q = (b->value[i * b->h.stride + k] - low) * inverse + 0.5f;
            sample[i * b->h.stride + k] = (uint8_t)(q < 255 ? q : 255);
        }
    }
}

/* Asks the caller's renderer what some eyes see. Returns what it returns: not 0 if the build ends. */
static int sfield__ask_views(sfield__build *b, size_t begin, size_t end)
{
    sfield_views views;
    memset(b->seen + begin * b->seen_size, 0, b->seen_size * (end - begin) * sizeof *b->seen);
    memcpy(views.center, b->h.center, sizeof views.center);
    views.radius = b->h.radius;
    views.time = b->time;
    views.count = end - begin;
    views.eyes = b->eyes + 3 * begin;
    views.values = b->seen + begin * b->seen_size;
    return b->see(b->see_user, &views);
}

/* Asks for all samples of the batch, then once more for those that are inside the mesh, a run of neighbours
   at a time. Returns not 0 if the build ends. */
static int sfield__ask_batch(sfield__build *b)
{
    size_t i, end, count = b->to - b->from;
    for (i = 0; i < count; i++) sfield__sample_point(b, b->from + i, b->eyes + 3 * i);
    if (sfield__ask_views(b, 0, count) != 0) return 1;
    if (b->triangles == 0 || b->h.kind != SFIELD__KIND_OCCLUSION || b->desc.keep_inside) return 0;
    sfield__run_tasks(b, sfield__find_inside_task);
    for (i = 0; i < count; i = end + 1) {
        while (i < count && !b->moved[i]) i++;
        for (end = i; end < count && b->moved[end];) end++;
        if (end > i && sfield__ask_views(b, i, end) != 0) return 1;
    }
    return 0;
}

static sfield_result sfield__build_batch(sfield__build *b, uint32_t group)
{
    size_t step = b->what == SFIELD__VIEWS ? (size_t)SFIELD__MOST_VIEWS : b->count;
    for (b->from = 0; b->from < b->count; b->from = b->to) {
        b->to = b->count - b->from < step ? b->count : b->from + step;
        if (b->what == SFIELD__VIEWS && sfield__ask_batch(b) != 0) return SFIELD_ERR_CANCELLED;
        sfield__run_tasks(b, sfield__build_task);
    }
#ifndef SFIELD_WITHOUT_WAVELETS
    if (b->h.basis == SFIELD_BASIS_HAAR) return sfield__append_wavelets(b, b->first);
#endif
    if (b->what != SFIELD__SELF) sfield__quantise(b, b->first, group);
    return SFIELD_OK;
}

/* ==== src/shadowfield/build_steps.h ==== */

/* ---- building: from a desc to a field ---- */

/* Makes the tables, the scratch of every task, and room for the values of a batch. */
static sfield_result sfield__prepare_build(sfield__build *b)
{
    const uint32_t haar = b->h.basis == SFIELD_BASIS_HAAR, planes = haar ? 0 : b->planes;
    const int mesh = b->triangles > 0, deep = b->what == SFIELD__EMISSIVE;
    size_t width = deep ? SFIELD__EMISSIVE_WIDTH : SFIELD__MOST_WIDTH, samples = 6 * width * width;
    size_t floats = b->h.channels * b->cells * (haar ? 2u : 1u) + (haar ? 2 * b->cells : 0), p;
    float *tables = (float *)sfield__hold_memory(b, b->cells, (4 + planes) * sizeof(float)), *all;
    uint8_t *buffers;
    double *work = NULL;
    uint32_t i, k;
    b->pieces = deep ? 4u : (uint32_t)SFIELD__PIECES;
    b->view = (sfield__view *)sfield__hold_memory(b, b->pieces, sizeof *b->view);
    all = (float *)sfield__hold_memory(b, b->pieces, floats * sizeof *all);
    buffers = (uint8_t *)sfield__hold_memory(b, b->pieces, mesh ? (deep ? 8 * samples : samples / 8) : 1);
    if (!tables || !b->view || !all || !buffers) return SFIELD_ERR_ALLOC;
    if (b->h.logarithm) {
        sfield_result result = sfield_algebra_create(b->h.bands, &b->desc.system, &b->algebra);
        work = (double *)sfield__hold_memory(b, b->pieces,
                                      2 * sizeof *work * b->h.bands * b->h.bands * b->h.bands * b->h.bands);
        if (result != SFIELD_OK || !work) return SFIELD_ERR_ALLOC;
    }
    memset(b->view, 0, b->pieces * sizeof *b->view);
    if (mesh) memset(buffers, 0, b->pieces * (deep ? 8 * samples : samples / 8));
    for (p = 0; p < b->pieces; p++) {
        sfield__view *v = &b->view[p];
        v->texel = all + p * floats;
        v->haar = v->texel + b->h.channels * b->cells;
        v->key = v->haar + b->h.channels * b->cells;
        v->bits = (uint64_t *)(void *)(buffers + p * (mesh && !deep ? samples / 8 : 0));
        v->depth = deep ? (float *)(void *)(buffers + 8 * p * samples) : NULL;
        v->owner = deep ? (uint32_t *)(void *)(v->depth + samples) : NULL;
        v->work = work ? work + 2 * p * b->h.bands * b->h.bands * b->h.bands * b->h.bands : NULL;
    }
    b->texels.direction = tables;
    b->texels.angle = tables + 3 * b->cells;
    b->texels.basis = tables + 4 * b->cells;
    memset(tables, 0, b->cells * (4 + planes) * sizeof *tables);
    for (i = 0; i < b->cells; i++) {
        b->texels.angle[i] = sfield_cube_texel(b->h.cube_side, i, b->texels.direction + 3 * i);
        if (!haar) sfield__texel_basis(b->h.bands, b->h.cube_side, i, b->texels.basis + (size_t)i * planes);
    }
    /* odd about the middle, and exact at the ends */
    for (i = 0, k = b->h.position_side; i < k; i++) {
        float s, c, a = 2 * (float)(i < k / 2 ? i : k - 1 - i) / (float)(k - 1) - 1;
        sfield__sincos(0.785398163f * a, &s, &c);
        b->texels.node[i] = (i == 0 || i == k - 1 ? -1 : s / c) * (i < k / 2 ? 1.0f : -1.0f);
    }
    return SFIELD_OK;
}

static sfield_result sfield__hold_batch(sfield__build *b, size_t batch)
{
    size_t held = b->what == SFIELD__SELF ? b->h.samples : batch;
    sfield_result result;
    if (b->what == SFIELD__VIEWS) {
        b->seen_size = b->h.channels * (b->h.bands ? b->h.bands * b->h.bands : b->cells);
        b->eyes = (float *)sfield__hold_memory(b, SFIELD__MOST_VIEWS, 3 * sizeof *b->eyes);
        b->seen = (float *)sfield__hold_memory(b, SFIELD__MOST_VIEWS, b->seen_size * sizeof *b->seen);
        b->moved = (uint8_t *)sfield__hold_memory(b, SFIELD__MOST_VIEWS, 1);
        if (!b->eyes || !b->seen || !b->moved) return SFIELD_ERR_ALLOC;
    }
#ifndef SFIELD_WITHOUT_WAVELETS
    if (b->h.basis == SFIELD_BASIS_HAAR) return sfield__hold_wavelets(b, batch);
#endif
    b->value = (float *)sfield__hold_memory(b, held, b->h.stride * sizeof *b->value);
    if (!b->value) return SFIELD_ERR_ALLOC;
    result = sfield__alloc_field(&b->allocator, &b->log, &b->h, &b->out);
    if (result == SFIELD_OK && b->h.shard_end) memset(b->out->words, 0, b->out->h.bytes);
    return result;
}

static sfield_result sfield__build_batches(sfield__build *b)
{
    const int self = b->what == SFIELD__SELF, haar = b->h.basis == SFIELD_BASIS_HAAR;
    const float *radiance = b->radiance;
    size_t batch = self ? 2048 : 6 * (size_t)b->h.position_side * b->h.position_side;
    uint32_t groups = self ? (b->h.samples + 2047) / 2048 : sfield__groups(&b->h), g;
    const uint32_t begin = b->h.shard_begin, end = b->h.shard_end ? b->h.shard_end : groups;
    float *values;
    sfield_result result = sfield__hold_batch(b, batch);
    if (!sfield__tell_progress(b, 0)) return SFIELD_ERR_CANCELLED;
    values = b->value;
    for (g = begin; g < end && result == SFIELD_OK; g++) {
        b->first = g * batch;
        b->count = self && b->h.samples - b->first < batch ? b->h.samples - b->first : batch;
        b->radius = self ? 0 : b->radii[g % b->h.shells];
        b->time = self ? 0 : (float)(g / b->h.shells) / b->h.frames_per_second;
        if (radiance) b->radiance = radiance + 3 * (size_t)(g / b->h.shells) * (b->triangles + b->skipped);
        if (self && !haar) b->value = values + b->first * b->h.stride;
        result = sfield__build_batch(b, g);
        if (result == SFIELD_OK && !sfield__tell_progress(b, (float)(g + 1 - begin) / (float)(end - begin)))
            return SFIELD_ERR_CANCELLED;
    }
    if (result != SFIELD_OK || !self || haar) return result;
    b->value = values;                          /* one range for all points */
    b->count = b->h.samples;
    sfield__quantise(b, 0, 0);
    return SFIELD_OK;
}

static sfield_result sfield__finish_field(sfield__build *b, sfield_field **out, sfield_stats *stats)
{
    double lost = 0, total = 0;
    const sfield__part silent = { NULL, NULL, 0, 1 };
    uint32_t p;
#ifndef SFIELD_WITHOUT_WAVELETS
    if (b->h.basis == SFIELD_BASIS_HAAR) {
        const sfield_result result = sfield__finish_wavelets(b);
        if (result != SFIELD_OK) return result;
    }
#endif
    if (b->h.kind == SFIELD__KIND_OCCLUSION && b->triangles) b->out->h.inscribed = sfield__find_inscribed(b);
    memcpy(b->out->words + SFIELD__HEADER, b->radii, b->h.shells * sizeof *b->radii);
    sfield__bind_shells(b->out);
    sfield__seal_block(b->out, &silent);
    b->peak = (b->peak > b->bytes ? b->peak : b->bytes) + b->out->h.bytes;
    if (stats) {
        memset(stats, 0, sizeof *stats);
        for (p = 0; p < b->pieces; p++) {
            lost += b->view[p].lost;
            total += b->view[p].total;
            stats->moved += b->view[p].moved;
        }
        stats->triangles = (uint32_t)b->triangles;
        stats->skipped_triangles = b->skipped;
        stats->coefficients = b->h.entries;
        stats->lost = total > 0 ? sqrt(lost / total) : 0;
        stats->peak_bytes = b->peak;
    }
    *out = b->out;
    b->out = NULL;
    return SFIELD_OK;
}

static sfield_result sfield__run_build(sfield__build *b, sfield_field **out, sfield_stats *stats)
{
    sfield_result result;
    if (sfield__block_bytes(&b->h) > 0xffffffffu)
        return sfield__fail(&b->log, SFIELD_ERR_LIMIT, "desc", "asks for a field of more than 4 GB");
    result = sfield__prepare_build(b);
    if (result == SFIELD_OK) result = sfield__build_batches(b);
    if (result == SFIELD_OK) result = sfield__finish_field(b, out, stats);
    if (result == SFIELD_ERR_LIMIT) sfield__log_text(&b->log, "desc", "asks for a field of more than 4 GB");
    return result;
}

/* ==== src/shadowfield/build.h ==== */

/* ---- building: the public calls ---- */

/* Frees all that a build holds, and returns the result. */
static sfield_result sfield__end_build(sfield__build *b, sfield_result result)
{
    if (result == SFIELD_ERR_ALLOC) sfield__log_text(&b->log, "desc.system.allocator", "returned no memory");
    sfield__release_build(b);
    return result;
}

/* Returns the log of a call, for what is wrong before its desc is read. */
static sfield__logger sfield__log_of_desc(const sfield_desc *desc, const char *function)
{
    return sfield__logger_of(desc ? &desc->system : NULL, function);
}

SFIELD_DEF sfield_result sfield_build(const sfield_desc *desc, const sfield_mesh *mesh, sfield_field **out,
                                      sfield_stats *stats)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_build");
    sfield__build b;
    sfield_result result;
    if (!mesh || !out) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, mesh ? "out" : "mesh", "is NULL");
    result = sfield__read_desc(&b, desc, SFIELD__KIND_OCCLUSION, log.function);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__MESH;
    result = sfield__take_mesh(&b, mesh);
    if (result == SFIELD_OK) result = sfield__run_build(&b, out, stats);
    return sfield__end_build(&b, result);
}

/* Checks the radiance of all triangles in all frames. Every number must be finite, 0..1e18. */
static sfield_result sfield__check_radiance(const sfield__build *b, const float *radiance, size_t count)
{
    size_t i;
    for (i = 0; i < count; i++)
        if (!sfield__in(radiance[i], 0, 1e18f)) {
            sfield__log_element(&b->log, "radiance", i, "is", (double)radiance[i], "0..1e18");
            return SFIELD_ERR_INPUT;
        }
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_build_emissive(const sfield_desc *desc, const sfield_mesh *mesh,
                                               const float *radiance, sfield_field **out, sfield_stats *stats)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_build_emissive");
    sfield__build b;
    sfield_result result;
    if (!mesh || !out || !radiance)
        return sfield__fail(&log, SFIELD_ERR_ARGUMENT, !mesh ? "mesh" : !out ? "out" : "radiance", "is NULL");
    result = sfield__read_desc(&b, desc, SFIELD__KIND_SOURCE, log.function);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__EMISSIVE;
    b.radiance = radiance;
    result = sfield__check_mesh(&b, mesh);
    if (result == SFIELD_OK)
        result = sfield__check_radiance(&b, radiance, 3 * (sfield__mesh_corners(mesh) / 3) * b.h.frames);
    if (result == SFIELD_OK) result = sfield__take_mesh(&b, mesh);
    if (result == SFIELD_OK) result = sfield__run_build(&b, out, stats);
    return sfield__end_build(&b, result);
}

SFIELD_DEF sfield_result sfield_build_emitter(const sfield_desc *desc, const sfield_emitter *emitter,
                                              sfield_field **out, sfield_stats *stats)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_build_emitter");
    sfield__build b;
    sfield_result result;
    if (!emitter || !out)
        return sfield__fail(&log, SFIELD_ERR_ARGUMENT, emitter ? "out" : "emitter", "is NULL");
    result = sfield__read_desc(&b, desc, SFIELD__KIND_SOURCE, log.function);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__ANALYTIC;
    b.emitter = *emitter;
    result = sfield__take_emitter(&b);
    if (result == SFIELD_OK) result = sfield__run_build(&b, out, stats);
    return sfield__end_build(&b, result);
}

SFIELD_DEF sfield_result sfield_build_callback(const sfield_desc *desc, sfield_view_fn alpha_fn, void *user,
                                               sfield_field **out, sfield_stats *stats)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_build_callback");
    sfield__build b;
    sfield_result result;
    if (!alpha_fn || !out || !desc)
        return sfield__fail(&log, SFIELD_ERR_ARGUMENT, !desc ? "desc" : !out ? "out" : "alpha_fn", "is NULL");
    result = sfield__read_desc(&b, desc, SFIELD__KIND_OCCLUSION, log.function);
    if (result == SFIELD_OK) result = sfield__need_radius(&b);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__CALLBACK;
    b.emitter.kind = SFIELD_EMITTER_CALLBACK;
    b.emitter.view_fn = alpha_fn;
    b.emitter.user = user;
    result = sfield__run_build(&b, out, stats);
    return sfield__end_build(&b, result);
}

SFIELD_DEF sfield_result sfield_build_views(const sfield_desc *desc, int source, const sfield_mesh *mesh,
                                            sfield_views_fn see_fn, void *user, sfield_field **out,
                                            sfield_stats *stats)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_build_views");
    sfield__build b;
    sfield_result result;
    if (!see_fn || !out || (!mesh && !desc))
        return sfield__fail(&log, SFIELD_ERR_ARGUMENT, !see_fn ? "see_fn" : !out ? "out" : "mesh", "is NULL");
    result = sfield__read_desc(&b, desc, source ? SFIELD__KIND_SOURCE : SFIELD__KIND_OCCLUSION, log.function);
    if (result == SFIELD_OK && !mesh) result = sfield__need_radius(&b);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__VIEWS;
    b.see = see_fn;
    b.see_user = user;
    if (mesh) result = sfield__take_mesh(&b, mesh);
    if (result == SFIELD_OK) result = sfield__run_build(&b, out, stats);
    return sfield__end_build(&b, result);
}

/* Checks that positions are finite and in range, and that normals are unit or 0. */
static sfield_result sfield__check_points(const sfield__logger *log, const sfield_points *p)
{
    size_t i, k;
    for (i = 0; i < p->count; i++) {
        const float *at = sfield__row(p->positions, p->position_stride, i);
        for (k = 0; k < 3; k++)
            if (!sfield__in(at[k], -1e18f, 1e18f)) {
                sfield__log_element(log, "points->positions", i, "has a coordinate", (double)at[k],
                                    "-1e18..1e18");
                return SFIELD_ERR_INPUT;
            }
        at = sfield__row(p->normals, p->normal_stride, i);
        if (!sfield__finite(at[0]) || !sfield__finite(at[1]) || !sfield__finite(at[2]))
            return sfield__fail_at(log, SFIELD_ERR_INPUT, "points->normals", i, "is not finite");
    }
    return sfield__check_units(log, "points->normals", p->normals, p->normal_stride, p->count);
}

SFIELD_DEF sfield_result sfield_build_self(const sfield_desc *desc, const sfield_mesh *mesh,
                                           const sfield_points *points, float offset, sfield_field **out,
                                           sfield_stats *stats)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_build_self");
    sfield__build b;
    sfield_result result;
    if (!mesh || !out || !points)
        return sfield__fail(&log, SFIELD_ERR_ARGUMENT, !mesh ? "mesh" : !out ? "out" : "points", "is NULL");
    if (!sfield__points_good(&log, points)) return SFIELD_ERR_ARGUMENT;
    if (!sfield__check_value(&log, points->count > 0, "points->count", 0, "> 0") ||
        !sfield__check_value(&log, sfield__in(offset, 0, 1e18f), "offset", (double)offset, "0..1e18"))
        return SFIELD_ERR_ARGUMENT;
    if (!sfield__check_value(&log, points->count <= 0x7fffffffu, "points->count", (double)points->count,
                      "below 2^31"))
        return SFIELD_ERR_LIMIT;
    result = sfield__check_points(&log, points);
    if (result != SFIELD_OK) return result;
    result = sfield__read_desc(&b, desc, SFIELD__KIND_SELF, log.function);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__SELF;
    b.points = points;
    b.offset = offset;
    b.h.samples = (uint32_t)points->count;
    result = sfield__take_mesh(&b, mesh);
    if (result == SFIELD_OK) result = sfield__run_build(&b, out, stats);
    return sfield__end_build(&b, result);
}

/* ==== src/shadowfield/build_placement.h ==== */

/* ---- building: shells and points where a measured error asks for them ---- */

enum { SFIELD__GRID = 129, SFIELD__AROUND = 26, SFIELD__ACROSS = 24 };

/* What is seen from places all round at many radii, as values whose squares add up to the integral over all
   directions. Shells are chosen among these radii. */
typedef struct sfield__profile {
    float    radius[SFIELD__GRID], measure[SFIELD__GRID];
    float    whole[SFIELD__GRID];   /* what errors at a radius are divided by */
    uint32_t shell[64], count;      /* chosen: their places in the grid */
} sfield__profile;

/* Returns how many values a view has: coefficients, or of wavelets squares of a face, 8 a side at most. */
static size_t sfield__count_values(const sfield__build *b)
{
    const uint32_t side = b->h.cube_side < 8 ? b->h.cube_side : 8;
    return b->h.basis == SFIELD_BASIS_HAAR ? (size_t)b->h.channels * 6 * side * side : b->h.stride;
}

/* Makes the values of what the view's texels hold. Squares are runs of texels, which are in Morton order. */
static void sfield__value_view(const sfield__build *b, sfield__view *v, float *out)
{
    const size_t squares = b->seen_size / b->h.channels, run = b->cells / squares;
    size_t c, i, k;
    if (b->h.basis != SFIELD_BASIS_HAAR) {
        sfield__encode_sh(b, v, NULL, out);
        return;
    }
    for (c = 0; c < b->h.channels; c++)
        for (i = 0; i < squares; i++) {
            float sum = 0, angle = 0;
            for (k = i * run; k < (i + 1) * run; k++) {
                sum += v->texel[c * b->cells + k] * b->texels.angle[k];
                angle += b->texels.angle[k];
            }
            out[c * squares + i] = sum / sqrtf(angle);
        }
}

/* Looks from each of b->eyes, as a build does. */
static void sfield__measure_task(void *context, size_t piece)
{
    const sfield__build *b = (const sfield__build *)context;
    sfield__view *v = &b->view[piece];
    size_t i;
    for (i = piece; i < b->to; i += b->pieces) {
        float eye[3];
        memcpy(eye, b->eyes + 3 * i, sizeof eye);
        sfield__view_from(b, v, eye);
        if (b->what == SFIELD__MESH && !b->desc.keep_inside &&
            sfield__move_out(b, sfield__share_hidden(b, v->texel), eye))
            sfield__view_from(b, v, eye);
        sfield__value_view(b, v, b->seen + i * b->seen_size);
    }
}

/* Returns the integral, over all directions, of the square of a (1 - t) + c t - what is seen. */
static double sfield__square_error(const sfield__build *b, const float *a, const float *c, float t,
                                   const float *seen)
{
    double sum = 0;
    size_t k;
    for (k = 0; k < b->seen_size; k++) {
        const float off = a[k] + t * (c[k] - a[k]) - seen[k];
        sum += (double)off * (double)off;
    }
    return sum;
}

/* Looks from all places of the profile. Errors of visibility are divided by 4 pi, those of sources by the
   light at their radius. */
static void sfield__measure_profile(sfield__build *b, sfield__profile *q)
{
    const float inner = b->radii[0], outer = b->radii[b->h.shells - 1];
    uint32_t i, j, k;
    for (i = 0; i < SFIELD__GRID; i++) {
        q->radius[i] = i + 1 < SFIELD__GRID
                           ? inner * sfield__pow(outer / inner, (float)i / (float)(SFIELD__GRID - 1))
                           : outer;
        q->measure[i] = sfield__measure_of(q->radius[i] * q->radius[i], b->h.kind, b->h.spacing);
        for (j = 0, k = 0; j < SFIELD__AROUND; j++, k++) {
            sfield__v3 d;
            k += k == 13;                       /* corners, edges and sides of a cube, turned a little */
            d = sfield__v3_make((float)(k % 3) - 1, (float)(k / 3 % 3) - 1, (float)(k / 9) - 1);
            d = sfield__v3_add(sfield__v3_normalize(d), sfield__v3_make(0.0131f, -0.0079f, 0.0107f));
            d = sfield__v3_scale(sfield__v3_normalize(d), q->radius[i]);
            sfield__v3_store(b->eyes + 3 * (i * SFIELD__AROUND + j), d);
        }
    }
    b->to = (size_t)SFIELD__GRID * SFIELD__AROUND;
    sfield__run_tasks(b, sfield__measure_task);
    for (i = 0; i < SFIELD__GRID; i++) {
        double sum = 4 * 3.14159265358979 * (double)SFIELD__AROUND;
        if (b->h.kind == SFIELD__KIND_SOURCE) {
            const float *seen = b->seen + (size_t)i * SFIELD__AROUND * b->seen_size;
            for (sum = 0, k = 0; k < SFIELD__AROUND * b->seen_size; k++)
                sum += (double)seen[k] * (double)seen[k];
        }
        q->whole[i] = (float)sqrt(sum);
    }
}

/* Returns the greatest error at the radii between two, interpolated as queries do. */
static float sfield__error_between(const sfield__build *b, const sfield__profile *q, uint32_t from,
                                   uint32_t to)
{
    const size_t row = SFIELD__AROUND * b->seen_size;
    float worst = 0;
    uint32_t i, j;
    for (i = from + 1; i < to; i++) {
        const float t = (q->measure[i] - q->measure[from]) / (q->measure[to] - q->measure[from]);
        double sum = 0;
        float error;
        for (j = 0; j < SFIELD__AROUND; j++) {
            const float *seen = b->seen + j * b->seen_size;
            sum += sfield__square_error(b, seen + from * row, seen + to * row, t, seen + i * row);
        }
        error = q->whole[i] > 0 ? (float)sqrt(sum) / q->whole[i] : 0;
        worst = error > worst ? error : worst;
    }
    return worst;
}

/* Goes outwards by the longest steps whose error is within a bound. Returns how many shells that takes, or
   one more than `most`. */
static uint32_t sfield__step_outwards(const sfield__build *b, sfield__profile *q, float bound,
                                      uint32_t most)
{
    uint32_t at = 0;
    for (q->count = 0; q->count < most;) {
        uint32_t next = at + 1;
        q->shell[q->count++] = at;
        if (at == SFIELD__GRID - 1) return q->count;
        while (next + 1 < SFIELD__GRID && sfield__error_between(b, q, at, next + 1) <= bound) next++;
        at = next;
    }
    return most + 1;
}

/* Returns the greatest error between neighbours among the chosen shells, and the first of the two; of equal
   ones those that are widest apart, so that there is always a radius between them. */
static float sfield__find_worst(const sfield__build *b, const sfield__profile *q, uint32_t *where)
{
    float worst = -1;
    uint32_t i;
    *where = 0;
    for (i = 0; i + 1 < q->count; i++) {
        const float error = sfield__error_between(b, q, q->shell[i], q->shell[i + 1]);
        const int wider = q->shell[i + 1] - q->shell[i] > q->shell[*where + 1] - q->shell[*where];
        if (!(error > worst) && !(error >= worst && wider)) continue;
        worst = error;
        *where = i;
    }
    return worst;
}

/* Chooses radii: as few as the bound allows, or those by which `most` shells err least. Returns the error, or
   a negative number if the bound cannot be kept. */
static float sfield__choose_radii(const sfield__build *b, sfield__profile *q, float bound, uint32_t most)
{
    float low = 1e-7f, high = 4, worst;
    uint32_t i, where;
    if (bound > 0) {
        if (sfield__step_outwards(b, q, bound, most) > most) return -1;
        return sfield__find_worst(b, q, &where);
    }
    /* few uniform shells of a source may err by many times its light */
    for (; sfield__step_outwards(b, q, high, most) > most && high < 1e30f; low = high, high *= 1024) { }
    for (i = 0; i < 22; i++) {
        const float middle = sqrtf(low * high);
        if (sfield__step_outwards(b, q, middle, most) > most) low = middle;
        else high = middle;
    }
    (void)sfield__step_outwards(b, q, high, most);
    worst = sfield__find_worst(b, q, &where);
    while (q->count < most) {                   /* those that are left halve what errs most */
        uint32_t *next = q->shell + where + 1;
        memmove(next + 1, next, (q->count++ - where - 1) * sizeof *next);
        *next = (next[-1] + next[1]) / 2;
        worst = sfield__find_worst(b, q, &where);
    }
    return worst;
}

/* Writes the four corners of a square of sample points, and its middle, on a sphere. */
static void sfield__aim_square(uint32_t side, uint32_t square, float radius, float *eyes)
{
    const float step = 1.57079633f / (float)(side - 1);
    const uint32_t x = (square & 1 ? 2 : 1) * (side - 2) / 3, y = (square & 2 ? 2 : 1) * (side - 2) / 3;
    uint32_t k, l;
    for (k = 0; k < 5; k++, eyes += 3) {
        const float a = (float)x + (k < 4 ? (float)(k & 1) : 0.5f);
        const float c = (float)y + (k < 4 ? (float)(k >> 1) : 0.5f);
        double d[3], length;
        float sine[2], cosine[2];
        sfield__sincos(step * a - 0.785398163f, &sine[0], &cosine[0]);
        sfield__sincos(step * c - 0.785398163f, &sine[1], &cosine[1]);
        sfield__from_face(square / 4, (double)(sine[0] / cosine[0]), (double)(sine[1] / cosine[1]), d);
        length = (double)radius / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        for (l = 0; l < 3; l++) eyes[l] = (float)(d[l] * length);
    }
}

/* Returns the error in the middles of squares of sample points, on the worst of the chosen shells, of fields
   with `side` points a side of a face. */
static float sfield__error_across(sfield__build *b, const sfield__profile *q, uint32_t side)
{
    float worst = 0;
    uint32_t i, j;
    b->h.position_side = side;
    for (i = 0; i < q->count; i++) {
        double sum = 0, whole = 0;
        for (j = 0; j < SFIELD__ACROSS; j++)
            sfield__aim_square(side, j, q->radius[q->shell[i]], b->eyes + 15 * j);
        b->to = 5 * SFIELD__ACROSS;
        sfield__run_tasks(b, sfield__measure_task);
        for (j = 0; j < SFIELD__ACROSS; j++) {
            float *seen = b->seen + 5 * j * b->seen_size, *middle = seen + 4 * b->seen_size;
            size_t v, n = b->seen_size;
            for (v = 0; v < n; v++) {
                seen[v] = 0.25f * (seen[v] + seen[v + n] + seen[v + 2 * n] + seen[v + 3 * n]);
                whole += (double)middle[v] * (double)middle[v];
            }
            sum += sfield__square_error(b, seen, seen, 0, middle);
        }
        if (b->h.kind != SFIELD__KIND_SOURCE) whole = 4 * 3.14159265358979 * (double)SFIELD__ACROSS;
        if (whole > 0 && sqrt(sum / whole) > (double)worst) worst = (float)sqrt(sum / whole);
    }
    return worst;
}

/* Chooses shells, then points. Half of the bound is for what lies between shells, half for what lies between
   the points of a shell. */
static sfield_result sfield__choose_places(sfield__build *b, float bound, sfield_placement *out)
{
    static const uint8_t sides[9] = { 4, 6, 8, 12, 16, 24, 32, 48, 64 };
    const uint32_t most = bound > 0 && !b->desc.shell_count ? 64 : b->h.shells, side = b->h.position_side;
    sfield__profile q;
    uint32_t i;
    memset(out, 0, sizeof *out);
    sfield__measure_profile(b, &q);
    if (!sfield__tell_progress(b, 0.5f)) return SFIELD_ERR_CANCELLED;
    out->between = sfield__choose_radii(b, &q, 0.5f * bound, most);
    if (!sfield__check_value(&b->log, out->between >= 0, "bound", (double)bound,
                             "more, or desc.shell_count more"))
        return SFIELD_ERR_LIMIT;
    out->shell_count = q.count;
    for (i = 0; i < q.count; i++) out->radii[i] = q.radius[q.shell[i]];
    for (i = 0; i < 9; i++) {
        out->position_side = bound > 0 && !b->desc.position_side ? sides[i] : side;
        out->across = sfield__error_across(b, &q, out->position_side);
        if (!sfield__tell_progress(b, 0.5f + 0.05f * (float)(i + 1))) return SFIELD_ERR_CANCELLED;
        if (!(bound > 0) || out->across <= 0.5f * bound) return SFIELD_OK;
        if (out->position_side != sides[i]) break;
    }
    (void)sfield__check_value(&b->log, 0, "bound", (double)bound, "more, or desc.position_side more");
    return SFIELD_ERR_LIMIT;
}

SFIELD_DEF sfield_result sfield_place(const sfield_desc *desc, const sfield_mesh *mesh,
                                      const sfield_emitter *emitter, float bound, sfield_placement *out)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_place");
    const size_t places = (size_t)SFIELD__GRID * SFIELD__AROUND;
    sfield_placement placement;
    sfield__build b;
    sfield_result result;
    if (!out) return sfield__fail_null(&log, "out");
    if (!mesh == !emitter)
        return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "mesh", "and emitter: one of both is to be given");
    if (!sfield__check_value(&log, sfield__in(bound, 0, 1), "bound", (double)bound, "0..1"))
        return SFIELD_ERR_ARGUMENT;
    result = sfield__read_desc(&b, desc, mesh ? SFIELD__KIND_OCCLUSION : SFIELD__KIND_SOURCE, log.function);
    if (result != SFIELD_OK) return result;
    b.what = mesh ? SFIELD__MESH : SFIELD__ANALYTIC;
    if (emitter) b.emitter = *emitter;
    result = mesh ? sfield__take_mesh(&b, mesh) : sfield__take_emitter(&b);
    if (result == SFIELD_OK) result = sfield__prepare_build(&b);
    if (result == SFIELD_OK) {
        b.seen_size = sfield__count_values(&b);
        b.eyes = (float *)sfield__hold_memory(&b, 3 * places, sizeof *b.eyes);
        b.seen = (float *)sfield__hold_memory(&b, places, b.seen_size * sizeof *b.seen);
        result = !b.eyes || !b.seen ? SFIELD_ERR_ALLOC
                 : sfield__tell_progress(&b, 0) ? sfield__choose_places(&b, bound, &placement)
                                                : SFIELD_ERR_CANCELLED;
    }
    if (result == SFIELD_OK) *out = placement;
    return sfield__end_build(&b, result);
}

/* ==== src/shadowfield/bounces.h ==== */

/* ---- one interreflection between bodies ---- */

#ifndef SFIELD_WITHOUT_BUILD
/* The light that a diffuse body sends on is a sum over patches: how bright each is now, times what it would
   radiate into the space around with a radiance of 1. What it would radiate is kept in source fields, three
   patches to a frame and one to a channel. */

enum { SFIELD__PATCH_POINTS = 4, SFIELD__MOST_PATCHES = 192 };

struct sfield_bounce {
    sfield__allocator allocator;
    sfield_field *transport, *source;
    uint32_t patches;
    float   *albedo;                            /* of each patch, 3 floats. What follows lies behind it */
    float   *positions, *normals;               /* of its points */
    float   *light, *values;                    /* radiance of each patch; a shell's coefficients */
};

typedef struct sfield__facet {                  /* a triangle */
    double area, feature[6];                    /* normal; middle, in r. What looks alike is near */
    uint32_t patch;
} sfield__facet;

/* Writes the corners of a triangle. Returns the greatest of their coordinates without its sign; a negative
   number if a build leaves the triangle out since they are not finite, or too far away. */
static float sfield__facet_corners(const sfield_mesh *mesh, size_t t, sfield__v3 *v)
{
    const size_t stride = mesh->vertex_stride ? mesh->vertex_stride : 12;
    float most = 0;
    uint32_t k, i;
    for (k = 0; k < 3; k++) {
        const float *p = sfield__vertex(mesh, stride, sfield__mesh_index(mesh, 3 * t + k));
        for (i = 0; i < 3; i++) {
            if (!sfield__finite(p[i]) || !(fabsf(p[i]) < 1e18f)) return -1;
            most = fabsf(p[i]) > most ? fabsf(p[i]) : most;
        }
        v[k] = sfield__v3_load(p);
    }
    return most;
}

/* Reads a triangle. Returns its area, 0 if it cannot be used. */
static double sfield__read_facet(const sfield_mesh *mesh, size_t t, float r, sfield__facet *out)
{
    sfield__v3 v[3], n, middle;
    double size;
    uint32_t k;
    memset(out, 0, sizeof *out);
    if (sfield__facet_corners(mesh, t, v) < 0) return 0;
    for (k = 0; k < 3; k++) v[k] = sfield__v3_scale(v[k], 1 / r);
    n = sfield__v3_cross(sfield__v3_sub(v[1], v[0]), sfield__v3_sub(v[2], v[0]));
    size = sqrt((double)sfield__v3_dot(n, n));
    if (!(size > 0)) return 0;
    middle = sfield__v3_scale(sfield__v3_add(sfield__v3_add(v[0], v[1]), v[2]), 1 / 3.0f);
    out->feature[0] = (double)n.x / size;
    out->feature[1] = (double)n.y / size;
    out->feature[2] = (double)n.z / size;
    out->feature[3] = (double)middle.x;
    out->feature[4] = (double)middle.y;
    out->feature[5] = (double)middle.z;
    out->area = 0.5 * size;
    return out->area;
}

/* Returns the spread of a patch along a feature: the sum of squares off the mean, which is written. */
static double sfield__spread_of(const sfield__facet *facets, size_t count, uint32_t patch, uint32_t feature,
                                double *mean)
{
    double area = 0, sum = 0, squares = 0;
    size_t i;
    for (i = 0; i < count; i++) {
        if (facets[i].patch != patch) continue;
        area += facets[i].area;
        sum += facets[i].area * facets[i].feature[feature];
    }
    *mean = area > 0 ? sum / area : 0;
    for (i = 0; i < count; i++)
        if (facets[i].patch == patch)
            squares += facets[i].area * (facets[i].feature[feature] - *mean) *
                       (facets[i].feature[feature] - *mean);
    return squares;
}

/* Cuts the surface: of all patches the one that is spread most, at its mean, again and again. Returns how
   many there are. */
static uint32_t sfield__cut_patches(sfield__facet *facets, size_t count, uint32_t most)
{
    double spread[SFIELD__MOST_PATCHES], mean[SFIELD__MOST_PATCHES], all = 0;
    uint32_t along[SFIELD__MOST_PATCHES], patches = 1, last = 0;
    uint32_t p, k, worst;
    size_t i;
    for (;;) {
        for (p = 0; p < patches; p++) {         /* of those that were just cut */
            if (p != last && p + 1 != patches) continue;
            spread[p] = -1;
            for (k = 0; k < 6; k++) {
                double at;
                const double s = sfield__spread_of(facets, count, p, k, &at);
                if (!(s > spread[p])) continue;
                spread[p] = s;
                mean[p] = at;
                along[p] = k;
            }
        }
        all = patches == 1 ? spread[0] : all;
        for (p = worst = 0; p < patches; p++) worst = spread[p] > spread[worst] ? p : worst;
        if (patches == most || !(spread[worst] > 1e-9 * all)) return patches;
        for (i = 0; i < count; i++)
            if (facets[i].patch == worst && facets[i].feature[along[worst]] > mean[worst])
                facets[i].patch = patches;
        last = worst;
        patches++;
    }
}

/* Fills in albedos and points, which lie in the middles of triangles, evenly by area. */
static void sfield__place_patches(sfield_bounce *b, const sfield__facet *facets, size_t count,
                                  const float *albedo, float r)
{
    const double points = SFIELD__PATCH_POINTS;
    uint32_t p, k, c;
    size_t i;
    for (p = 0; p < b->patches; p++) {
        double area = 0, before = 0, sum[3] = { 0, 0, 0 };
        for (i = 0; i < count; i++)
            for (c = 0; c < 3 && facets[i].patch == p; c++) {
                area += c ? 0 : facets[i].area;
                sum[c] += facets[i].area * (double)albedo[3 * i + c];
            }
        for (c = 0; c < 3; c++) b->albedo[3 * p + c] = (float)(sum[c] / area);
        for (i = 0, k = 0; i < count; i++) {
            if (facets[i].patch != p || !(facets[i].area > 0)) continue;
            before += facets[i].area;
            /* point k goes where (k + 0.5) / 4 of the area are reached */
            for (; k < SFIELD__PATCH_POINTS && ((double)k + 0.5) * area < points * before; k++)
                for (c = 0; c < 3; c++) {
                    const size_t at = 3 * ((size_t)p * SFIELD__PATCH_POINTS + k) + c;
                    b->positions[at] = (float)(facets[i].feature[3 + c] * (double)r);
                    b->normals[at] = (float)facets[i].feature[c];
                }
        }
    }
}

static sfield_result sfield__fail_memory(const sfield__logger *log)
{
    return sfield__fail(log, SFIELD_ERR_ALLOC, "desc.system.allocator", "returned no memory");
}

/* Builds the source fields of all patches as one whose frames they are. */
static sfield_result sfield__build_transport(sfield_bounce *b, const sfield_desc *desc,
                                             const sfield_mesh *mesh, const sfield__facet *facets,
                                             size_t count, const sfield__logger *log)
{
    const uint32_t frames = (b->patches + 2) / 3;
    sfield_desc d = *desc;
    sfield_result result;
    float *radiance;
    size_t i, cells;
    d.frame_count = frames;
    d.frames_per_second = 1;
    d.loop = 0;
    d.shard_begin = d.shard_end = 0;
    radiance = sfield__mul_size(count, frames, &cells)
                   ? (float *)sfield__alloc_array(&b->allocator, cells, 3 * sizeof *radiance)
                   : NULL;
    if (!radiance) return sfield__fail_memory(log);
    memset(radiance, 0, 3 * cells * sizeof *radiance);
    for (i = 0; i < count; i++)
        radiance[3 * (facets[i].patch / 3 * count + i) + facets[i].patch % 3] = facets[i].area > 0 ? 1.0f : 0;
    result = sfield_build_emissive(&d, mesh, radiance, &b->transport, NULL);
    sfield__free(&b->allocator, radiance);
    return result;
}

/* Allocates the source of the body, which is like one frame of b->transport, and the coefficients of a shell,
   in which sfield__mix_patches adds up the patches. */
static sfield_result sfield__make_room(sfield_bounce *b, const sfield__logger *log)
{
    const size_t samples = 6 * (size_t)b->transport->h.position_side * b->transport->h.position_side;
    sfield__header h = b->transport->h;
    h.samples /= h.frames;
    h.frames = 1;
    b->values = (float *)sfield__alloc_array(&b->allocator, samples * h.stride, sizeof *b->values);
    if (!b->values || sfield__alloc_field(&b->allocator, log, &h, &b->source) != SFIELD_OK)
        return sfield__fail_memory(log);
    memset(b->light, 0, 3 * b->patches * sizeof *b->light);
    memcpy(b->source->words + SFIELD__HEADER, b->transport->radii, h.shells * sizeof *b->transport->radii);
    sfield__bind_shells(b->source);
    return SFIELD_OK;
}

/* Adds up the patches of a shell, each as bright as it is. */
static void sfield__mix_patches(const sfield_bounce *b, uint32_t shell, size_t samples)
{
    const sfield_field *f = b->transport;
    const uint32_t planes = f->planes, stride = f->h.stride, side = f->h.shells;
    uint32_t p, c, k;
    size_t i;
    memset(b->values, 0, samples * stride * sizeof *b->values);
    for (p = 0; p < b->patches; p++) {
        const size_t group = (size_t)(p / 3) * side + shell;
        const float *scale = f->scale + group * stride + p % 3 * planes;
        const float *bias = f->bias + group * stride + p % 3 * planes;
        const uint8_t *q = f->sample + group * samples * stride + p % 3 * planes;
        float *out = b->values, x[SFIELD_MAX_COEFS];
        for (i = 0; i < samples; i++, q += stride, out += stride) {
            for (k = 0; k < planes; k++) x[k] = scale[k] * (float)q[k] + bias[k];
            for (c = 0; c < 3; c++)
                for (k = 0; k < planes; k++) out[c * planes + k] += b->light[3 * p + c] * x[k];
        }
    }
}

/* Writes the source field by the light of the patches. */
static void sfield__fill_source(sfield_bounce *b)
{
    const size_t samples = 6 * (size_t)b->source->h.position_side * b->source->h.position_side;
    const sfield__part silent = { NULL, NULL, 0, 1 };
    sfield__build build;
    uint32_t shell;
    memset(&build, 0, sizeof build);
    build.h = b->source->h;
    build.out = b->source;
    build.value = b->values;
    build.count = samples;
    for (shell = 0; shell < b->source->h.shells; shell++) {
        sfield__mix_patches(b, shell, samples);
        sfield__quantise(&build, shell * samples, shell);
    }
    (void)sfield__seal_block(b->source, &silent);
}

/* Allocates the patches, once it is known how many there are. */
static sfield_result sfield__make_patches(sfield_bounce *b, const sfield__logger *log)
{
    const size_t points = (size_t)b->patches * SFIELD__PATCH_POINTS;
    b->albedo = (float *)sfield__alloc_array(&b->allocator, 6 * points + 6 * (size_t)b->patches,
                                             sizeof *b->albedo);
    if (!b->albedo) return sfield__fail_memory(log);
    b->light = b->albedo + 3 * (size_t)b->patches;
    b->positions = b->light + 3 * (size_t)b->patches;
    b->normals = b->positions + 3 * points;
    return SFIELD_OK;
}

static sfield_result sfield__fill_bounce(sfield_bounce *b, const sfield_desc *desc, const sfield_mesh *mesh,
                                         const float *albedo, uint32_t patch_count,
                                         const sfield__logger *log)
{
    const size_t count = sfield__mesh_corners(mesh) / 3;
    float r = 0;
    double area = 0;
    sfield_result result = SFIELD_OK;
    sfield__facet *facets =
        (sfield__facet *)sfield__alloc_array(&b->allocator, count, sizeof *facets);
    size_t i;
    if (!facets) return sfield__fail_memory(log);
    for (i = 0; i < count; i++) {       /* vertices that no triangle has do not count */
        sfield__v3 v[3];
        const float most = sfield__facet_corners(mesh, i, v);
        r = most > r ? most : r;
    }
    r = r > 1e-18f ? r : 1.0f;
    for (i = 0; i < count; i++) area += sfield__read_facet(mesh, i, r, &facets[i]);
    if (!(area > 0)) result = sfield__fail(log, SFIELD_ERR_INPUT, "mesh", "has no triangle with an area");
    if (result == SFIELD_OK) {
        b->patches = sfield__cut_patches(facets, count, patch_count);
        result = sfield__make_patches(b, log);
    }
    if (result == SFIELD_OK) {
        sfield__place_patches(b, facets, count, albedo, r);
        result = sfield__build_transport(b, desc, mesh, facets, count, log);
    }
    if (result == SFIELD_OK) result = sfield__make_room(b, log);
    if (result == SFIELD_OK) sfield__fill_source(b);
    sfield__free(&b->allocator, facets);
    return result;
}

/* Checks what sfield_build_emissive does not, or too late. */
static sfield_result sfield__check_bounce(const sfield__logger *log, const sfield_desc *d,
                                          const sfield_mesh *mesh, const float *albedo, uint32_t patch_count)
{
    sfield__build b;
    sfield_result result;
    size_t i;
    if (!sfield__check_value(log, patch_count <= SFIELD__MOST_PATCHES, "patch_count", patch_count, "0..192"))
        return SFIELD_ERR_ARGUMENT;
    if (d->basis == SFIELD_BASIS_HAAR)
        return sfield__fail(log, SFIELD_ERR_DESC, "desc.basis", "is of wavelets");
    result = sfield__read_desc(&b, d, SFIELD__KIND_SOURCE, log->function);
    if (result == SFIELD_OK) result = sfield__check_mesh(&b, mesh);
    for (i = 0; result == SFIELD_OK && i < sfield__mesh_corners(mesh); i++)
        if (!sfield__in(albedo[i], 0, 1)) {
            sfield__log_element(log, "albedo", i, "is", (double)albedo[i], "0..1");
            return SFIELD_ERR_INPUT;
        }
    return result;
}

SFIELD_DEF sfield_result sfield_bounce_create(const sfield_desc *desc, const sfield_mesh *mesh,
                                              const float *albedo, uint32_t patch_count, sfield_bounce **out)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_bounce_create");
    sfield__allocator a;
    sfield_desc d;
    sfield_bounce *b;
    sfield_result result;
    if (!mesh || !albedo || !out) return sfield__fail_null(&log, !mesh ? "mesh" : !albedo ? "albedo" : "out");
    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    result = sfield__check_bounce(&log, &d, mesh, albedo, patch_count);
    if (result != SFIELD_OK) return result;
    a = sfield__allocator_of(&d.system);
    b = (sfield_bounce *)sfield__alloc(&a, sizeof *b);
    if (!b) return sfield__fail_memory(&log);
    memset(b, 0, sizeof *b);
    b->allocator = a;
    result = sfield__fill_bounce(b, &d, mesh, albedo, patch_count ? patch_count : 24, &log);
    if (result != SFIELD_OK) {
        sfield_bounce_free(b);
        return result;
    }
    *out = b;
    return SFIELD_OK;
}

SFIELD_DEF void sfield_bounce_free(sfield_bounce *bounce)
{
    sfield__allocator a;
    if (!bounce) return;
    a = bounce->allocator;
    sfield_free(bounce->transport);
    sfield_free(bounce->source);
    sfield__free(&a, bounce->albedo);
    sfield__free(&a, bounce->values);
    sfield__free(&a, bounce);
}

SFIELD_DEF void sfield_bounce_points(const sfield_bounce *bounce, sfield_points *out)
{
    if (!bounce || !out) return;
    memset(out, 0, sizeof *out);
    out->count = (size_t)bounce->patches * SFIELD__PATCH_POINTS;
    out->positions = bounce->positions;
    out->normals = bounce->normals;
}

SFIELD_DEF sfield_result sfield_bounce_update(sfield_bounce *bounce, const float *rgb)
{
    uint32_t p, k, c;
    if (!bounce) return SFIELD_ERR_ARGUMENT;
    if (!rgb) {
        const sfield__logger log = sfield__logger_for(&bounce->source->log, "sfield_bounce_update");
        return sfield__fail_null(&log, "rgb");
    }
    for (p = 0; p < bounce->patches; p++)
        for (c = 0; c < 3; c++) {
            float sum = 0;
            for (k = 0; k < SFIELD__PATCH_POINTS; k++) {
                const float x = rgb[3 * ((size_t)p * SFIELD__PATCH_POINTS + k) + c];
                sum += sfield__finite(x) && x > 0 ? (x < 1e18f ? x : 1e18f) : 0;
            }
            bounce->light[3 * p + c] = bounce->albedo[3 * p + c] * sum / (float)SFIELD__PATCH_POINTS;
        }
    sfield__fill_source(bounce);
    return SFIELD_OK;
}

SFIELD_DEF const sfield_field *sfield_bounce_source(const sfield_bounce *bounce)
{
    return bounce ? bounce->source : NULL;
}
#endif

/* ==== src/shadowfield/scene_state.h ==== */

/* ---- scenes: what they hold ---- */

enum { SFIELD__CACHED = 256 };      /* wavelets of T that the lazy cache keeps for a point and light */

#define SFIELD__NONE 0xffffffffu     /* no entity */

typedef struct sfield__item {       /* of an entity */
    sfield_entity e;
    float    turn[9];               /* world to field directions, rows */
    float center[2][3], inverse[2], radius[2]; /* of occlusion and source: world center, 1 / (scale r), world
                                                  radius */
    float    inscribed, reach;      /* of the occluder, world */
    float    was[3];                /* center[0] before the last change of the scene */
    int      identity;
#ifndef SFIELD_WITHOUT_ROOMS
    int      holds;                 /* not 0: a light lies in the hull of the occluder */
#endif
    uint32_t map;                   /* wavelets, rotated: 1 + which resampling table */
    uint64_t field, body, light;    /* hashes, 0 where there is none: of the occlusion field, by address and
                                       by checksum, since another one may come to lie at the same address; of
                                       that and where it stands; of the source and all that shines by it */
} sfield__item;

typedef struct sfield__taps { uint16_t texel[4]; float weight[4]; } sfield__taps;

#ifndef SFIELD_WITHOUT_HIERARCHY
typedef struct sfield__ball { float center[3], radius; } sfield__ball;

typedef struct sfield__tree {       /* occluders along a curve, and spheres about what they reach */
    uint64_t     *keys, *order;     /* of each occluder: its place along the curve, and in the lower half its
                                       item. Room for twice as many; half of it, where they are in order */
    sfield__ball *ball, *level[8];  /* of 4 occluders each, of 16, ... */
    uint32_t      count, levels;
} sfield__tree;

typedef struct sfield__walk {       /* how far the occluders are looked through that may reach a sphere */
    const sfield__tree *tree;
    float    middle[3], extent;
    uint32_t at, level;
} sfield__walk;
#endif

#ifndef SFIELD_WITHOUT_ROOMS
struct sfield__tenant { uint32_t light, item; };  /* a light in the hull of an entity: part rooms.h */
static int sfield__find_rooms(sfield_scene *s);
#endif

#ifndef SFIELD_WITHOUT_GLOSS
typedef struct sfield__brdf sfield__brdf;    /* BRDFs as harmonics: part gloss.h */
#endif

struct sfield_scene {
    sfield__allocator allocator;
    sfield_scene_desc desc;
    sfield_algebra   *algebra;
    int               simd;
    uint32_t          coefs, planes, cells, side;
    sfield__item     *item;
    sfield_rotation  *rotation;
    sfield__taps     *taps;
    uint32_t *occluder, *light, item_count, occluder_count;
    uint32_t light_count, overlaps, maps;
#ifndef SFIELD_WITHOUT_HIERARCHY
    sfield__tree tree;
#endif
#ifndef SFIELD_WITHOUT_ROOMS
    struct sfield__tenant *held;      /* lights that lie in the hull of another entity */
    uint32_t          held_count;
#endif
#ifndef SFIELD_WITHOUT_GLOSS
    sfield__brdf     *brdf;         /* harmonics: made when the first set with materials comes */
#endif
    /* Hashes of all that results depend on besides the points: the entities, the environment; both; and both
       as they were before the last change, 0 if that did more than move the occluders of `moved`. */
    uint64_t          entities_hash, sky_hash, now_hash, before_hash;
    uint32_t         *moved, moved_count;
    float            *sky;          /* as set: cube of texels, 3 planes; kept unturned */
    float            *sky_now;      /* harmonics: 3 x n^2; wavelets: 3 x 6 N^2 texels, then their
                                       coefficients */
    float            *sky_still;    /* harmonics: as set, not turned */
    float            *sun;          /* of the sun, as set, not turned */
    int               has_sky, has_sun;
    float             sky_turn[16];
    float            *texel;        /* x, y, z, solid angle: four planes of 6 N^2 */
    uint8_t          *scratch;
    size_t            scratch_bytes;
};

typedef struct sfield__last {       /* a tile or a point, when its results were kept */
    uint64_t seen;                  /* hash of all that they depend on; 0 = nothing kept */
    float    middle[3], extent;     /* a sphere about the points */
    uint32_t in_view, active;       /* bits: points that were in view; those that can be shaded: others give
                                       0 */
    int      has;                   /* which results */
} sfield__last;

struct sfield_cache {
    sfield__allocator allocator;
    size_t    points, bytes;
    uint32_t  lights, coefs, cells; /* cells 0: harmonics */
    uint32_t  chains;               /* room for so many T of a point and light: 1, with gloss 2 or 3 */
    uint64_t *hash;                 /* harmonics: tiles x lights; wavelets: points x lights x chains; 0 =
                                       nothing kept. What follows lies in the memory that begins here */
    int16_t  *value;
    uint16_t *index;                /* wavelets: of each value */
    float    *scale;
    uint64_t *lit;                  /* wavelets: hash and sky that sky is of, 3 floats a point and chain;
                                       harmonics: what the marks of a tile are of */
    float    *sky;
    uint8_t  *marks;                /* harmonics: of each tile, how many T are kept of those that all lights
                                       have in common */
    sfield__last *last;             /* of each tile (harmonics) or point */
    float    *result;               /* of the last frame: r, g, b, ambient of each point, and with room for
                                       gloss three of that and three of grazing */
};

/* ==== src/shadowfield/wavelets_strands.h ==== */

/* ---- wavelets: what sixteen points share ---- */

/* Neighbours whose entities have the same order from near to far are shaded together, a lane each, face by
   face. Texels, wavelets and sums are planes of sixteen, so that directions, the sky, and the samples that
   several points lie between are read once for all lanes. */
enum { SFIELD__STRANDS = 32, SFIELD__STRAND_LISTS = 256, SFIELD__BLOCK = 64, SFIELD__FEWEST = 3 };

typedef struct sfield__listing {    /* what is kept at a sample, and how much of it each point takes */
    const uint32_t *e, *end;
    size_t sample;
    float weight[SFIELD__LANES];
} sfield__listing;

typedef struct sfield__strand {     /* an entity in the order */
    uint32_t item, lanes, count;
    int      light;                 /* its number, -1 an occluder, -2 the self-visibility */
    float    d2[SFIELD__LANES];
    sfield__listing *list;          /* room for SFIELD__STRAND_LISTS: 16 points between 8 samples of 2
                                       frames */
} sfield__strand;

typedef struct sfield__bundle {
    const sfield_scene *s;
    sfield__strand *strand, *trial;
    sfield__listing *list;
    uint32_t strands;
    int      ambient;
    float    n[3 * SFIELD__LANES];
    float   *t, *w;                 /* a face: texels of T; its wavelets, or those of what hides it */
    uint16_t *used;                 /* squares of a face with wavelets */
    uint8_t *marks;
    uint8_t  live[SFIELD__BLOCK];   /* blocks of 64 texels where T is not 0 */
    float    rgb[3 * SFIELD__LANES], open[SFIELD__LANES];
} sfield__bundle;

/* ==== src/shadowfield/kernels_begin.h ==== */

/* ---- kernels: one text, compiled for every instruction set ---- */

/* Names that every instruction set has of its own, see unit simd. */
#define sfield__pair SFIELD__NAME_IN_SET(sfield__pair, SFIELD__SET)
#define sfield__product_begin SFIELD__NAME_IN_SET(sfield__product_begin, SFIELD__SET)
#define sfield__product_end SFIELD__NAME_IN_SET(sfield__product_end, SFIELD__SET)
#define sfield__product SFIELD__NAME_IN_SET(sfield__product, SFIELD__SET)
#define sfield__pairs4 SFIELD__NAME_IN_SET(sfield__pairs4, SFIELD__SET)
#define sfield__term SFIELD__NAME_IN_SET(sfield__term, SFIELD__SET)
#define sfield__four_terms SFIELD__NAME_IN_SET(sfield__four_terms, SFIELD__SET)
#define sfield__terms4 SFIELD__NAME_IN_SET(sfield__terms4, SFIELD__SET)
#define sfield__product4 SFIELD__NAME_IN_SET(sfield__product4, SFIELD__SET)
#define sfield__rotate SFIELD__NAME_IN_SET(sfield__rotate, SFIELD__SET)
#define sfield__held SFIELD__NAME_IN_SET(sfield__held, SFIELD__SET)
#define sfield__row3 SFIELD__NAME_IN_SET(sfield__row3, SFIELD__SET)
#define sfield__row5 SFIELD__NAME_IN_SET(sfield__row5, SFIELD__SET)
#define sfield__row7 SFIELD__NAME_IN_SET(sfield__row7, SFIELD__SET)
#define sfield__rotate4 SFIELD__NAME_IN_SET(sfield__rotate4, SFIELD__SET)
#define sfield__corner_weights SFIELD__NAME_IN_SET(sfield__corner_weights, SFIELD__SET)
#define sfield__corner_weights_of SFIELD__NAME_IN_SET(sfield__corner_weights_of, SFIELD__SET)
#define sfield__shells SFIELD__NAME_IN_SET(sfield__shells, SFIELD__SET)
#define sfield__shells_of SFIELD__NAME_IN_SET(sfield__shells_of, SFIELD__SET)
#define sfield__between_four SFIELD__NAME_IN_SET(sfield__between_four, SFIELD__SET)
#define sfield__between_eight SFIELD__NAME_IN_SET(sfield__between_eight, SFIELD__SET)
#define sfield__eight_to_planes SFIELD__NAME_IN_SET(sfield__eight_to_planes, SFIELD__SET)
#define sfield__eight_times SFIELD__NAME_IN_SET(sfield__eight_times, SFIELD__SET)
#define sfield__mix_row SFIELD__NAME_IN_SET(sfield__mix_row, SFIELD__SET)
#define sfield__singles_times SFIELD__NAME_IN_SET(sfield__singles_times, SFIELD__SET)
#define sfield__mix SFIELD__NAME_IN_SET(sfield__mix, SFIELD__SET)
#define sfield__widen SFIELD__NAME_IN_SET(sfield__widen, SFIELD__SET)
#define sfield__transpose SFIELD__NAME_IN_SET(sfield__transpose, SFIELD__SET)
#define sfield__add_parts SFIELD__NAME_IN_SET(sfield__add_parts, SFIELD__SET)
#define sfield__planes_times SFIELD__NAME_IN_SET(sfield__planes_times, SFIELD__SET)
#define sfield__warp_angle SFIELD__NAME_IN_SET(sfield__warp_angle, SFIELD__SET)
#define sfield__node_before SFIELD__NAME_IN_SET(sfield__node_before, SFIELD__SET)
#define sfield__lanes_measure SFIELD__NAME_IN_SET(sfield__lanes_measure, SFIELD__SET)
#define sfield__weigh_shells SFIELD__NAME_IN_SET(sfield__weigh_shells, SFIELD__SET)
#define sfield__locate SFIELD__NAME_IN_SET(sfield__locate, SFIELD__SET)
#define sfield__same_eight SFIELD__NAME_IN_SET(sfield__same_eight, SFIELD__SET)
#define sfield__select SFIELD__NAME_IN_SET(sfield__select, SFIELD__SET)
#define sfield__to_local SFIELD__NAME_IN_SET(sfield__to_local, SFIELD__SET)
#define sfield__nearer SFIELD__NAME_IN_SET(sfield__nearer, SFIELD__SET)
#define sfield__look_at SFIELD__NAME_IN_SET(sfield__look_at, SFIELD__SET)
#define sfield__fade SFIELD__NAME_IN_SET(sfield__fade, SFIELD__SET)
#define sfield__recall SFIELD__NAME_IN_SET(sfield__recall, SFIELD__SET)
#define sfield__at_least_0 SFIELD__NAME_IN_SET(sfield__at_least_0, SFIELD__SET)
#define sfield__any_lane SFIELD__NAME_IN_SET(sfield__any_lane, SFIELD__SET)
#define sfield__face_start SFIELD__NAME_IN_SET(sfield__face_start, SFIELD__SET)
#define sfield__face_add_list SFIELD__NAME_IN_SET(sfield__face_add_list, SFIELD__SET)
#define sfield__face_dim SFIELD__NAME_IN_SET(sfield__face_dim, SFIELD__SET)
#define sfield__face_darken SFIELD__NAME_IN_SET(sfield__face_darken, SFIELD__SET)
#define sfield__face_hide SFIELD__NAME_IN_SET(sfield__face_hide, SFIELD__SET)
#define sfield__face_level SFIELD__NAME_IN_SET(sfield__face_level, SFIELD__SET)
#define sfield__face_transform SFIELD__NAME_IN_SET(sfield__face_transform, SFIELD__SET)
#define sfield__face_light SFIELD__NAME_IN_SET(sfield__face_light, SFIELD__SET)
#define sfield__face_finish SFIELD__NAME_IN_SET(sfield__face_finish, SFIELD__SET)
#define sfield__face_shade SFIELD__NAME_IN_SET(sfield__face_shade, SFIELD__SET)
#define sfield__haar_squares SFIELD__NAME_IN_SET(sfield__haar_squares, SFIELD__SET)
#define sfield__fill_cosines SFIELD__NAME_IN_SET(sfield__fill_cosines, SFIELD__SET)
#define sfield__dot_sky SFIELD__NAME_IN_SET(sfield__dot_sky, SFIELD__SET)
#define sfield__dim_texels SFIELD__NAME_IN_SET(sfield__dim_texels, SFIELD__SET)
#define sfield__shade_fours SFIELD__NAME_IN_SET(sfield__shade_fours, SFIELD__SET)
#define sfield__shade_square SFIELD__NAME_IN_SET(sfield__shade_square, SFIELD__SET)
#define sfield__darken SFIELD__NAME_IN_SET(sfield__darken, SFIELD__SET)

#define SFIELD__SET plain
#define SFIELD__WIDTH SFIELD__SIMD_WIDTH
#define SFIELD__LANE_COUNT 16

#endif /* !SHADOWFIELD_IMPLEMENTED */

#ifdef SFIELD__SET
#if SFIELD__SIMD_SETS
#if SFIELD_VERSION != 10000 /* this file's: another one that includes it as SFIELD_FILE has its own */
#error "shadowfield.h: the file that SFIELD_FILE names is of another version than the one that includes it"
#endif
#endif

/* ==== src/shared/simd_begin.h ==== */

/* unit simd_begin, needs simd: what the kernels of one instruction set are compiled with */

#undef SFIELD__KERNEL
#undef SFIELD__IN_KERNEL
#undef SFIELD__IN_LARGE_KERNEL
#undef SFIELD__INTEL
#undef SFIELD__EACH

#if SFIELD__WIDTH == 16
#define SFIELD__KERNEL SFIELD__TARGET_AVX512
#elif SFIELD__WIDTH == 8
#define SFIELD__KERNEL SFIELD__TARGET_AVX2
#else
#define SFIELD__KERNEL
#endif

#if SFIELD__WIDTH == 16
#define SFIELD__INTEL(name) _mm512_##name
#elif SFIELD__WIDTH == 8
#define SFIELD__INTEL(name) _mm256_##name
#else
#define SFIELD__INTEL(name) _mm_##name
#endif

/* SFIELD__IN_LARGE_KERNEL stands after `static`, before a function that a kernel calls dozens of times. Such a
   function is not inlined without optimisation, nor with gcc's sanitizers, which take minutes to build large
   functions. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define SFIELD__IN_KERNEL __attribute__((always_inline)) SFIELD__KERNEL
#else
#define SFIELD__IN_KERNEL SFIELD__KERNEL
#endif
#if defined(__GNUC__) && !defined(__TINYC__) && (!defined(__OPTIMIZE__) || defined(__SANITIZE_ADDRESS__))
#define SFIELD__IN_LARGE_KERNEL __attribute__((noinline)) SFIELD__KERNEL
#else
#define SFIELD__IN_LARGE_KERNEL inline SFIELD__IN_KERNEL
#endif

/* SFIELD__EACH executes statements for every piece of SFIELD__WIDTH lanes. The number of the piece is a constant in
   them, so that compilers keep pieces in registers. */
#if SFIELD__WIDTH > 1 && SFIELD__LANE_COUNT == SFIELD__WIDTH
#define SFIELD__EACH(...) { enum { piece = 0 }; __VA_ARGS__; }
#elif SFIELD__WIDTH > 1 && SFIELD__LANE_COUNT == 2 * SFIELD__WIDTH
#define SFIELD__EACH(...) { enum { piece = 0 }; __VA_ARGS__; } { enum { piece = 1 }; __VA_ARGS__; }
#elif SFIELD__WIDTH > 1 && SFIELD__LANE_COUNT == 4 * SFIELD__WIDTH
#define SFIELD__EACH(...) \
    { enum { piece = 0 }; __VA_ARGS__; } { enum { piece = 1 }; __VA_ARGS__; } \
    { enum { piece = 2 }; __VA_ARGS__; } { enum { piece = 3 }; __VA_ARGS__; }
#else
#define SFIELD__EACH(...) \
    { int piece; for (piece = 0; piece < SFIELD__LANE_COUNT / SFIELD__WIDTH; piece++) { __VA_ARGS__; } }
#endif

/* ==== src/shared/simd_x86.h ==== */

/* unit simd_x86, needs simd_begin: lanes of SSE2, AVX2 and AVX-512 */

#if SFIELD__SIMD_X86 || SFIELD__WIDTH > 4

#if SFIELD__WIDTH == 16
typedef struct sfield__lanes { __m512 v[SFIELD__LANE_COUNT / 16]; } sfield__lanes;
typedef struct sfield__lane_ints { __m512i v[SFIELD__LANE_COUNT / 16]; } sfield__lane_ints;
typedef struct sfield__lane_mask { __mmask16 v[SFIELD__LANE_COUNT / 16]; } sfield__lane_mask;
#elif SFIELD__WIDTH == 8
typedef struct sfield__lanes { __m256 v[SFIELD__LANE_COUNT / 8]; } sfield__lanes;
typedef struct sfield__lane_ints { __m256i v[SFIELD__LANE_COUNT / 8]; } sfield__lane_ints;
typedef struct sfield__lane_mask { __m256 v[SFIELD__LANE_COUNT / 8]; } sfield__lane_mask;
#else
typedef struct sfield__lanes { __m128 v[SFIELD__LANE_COUNT / 4]; } sfield__lanes;
typedef struct sfield__lane_ints { __m128i v[SFIELD__LANE_COUNT / 4]; } sfield__lane_ints;
typedef struct sfield__lane_mask { __m128 v[SFIELD__LANE_COUNT / 4]; } sfield__lane_mask;
#endif

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_load(const float *from)
{
    sfield__lanes a;
    SFIELD__EACH(a.v[piece] = SFIELD__INTEL(loadu_ps)(from + piece * SFIELD__WIDTH))
    return a;
}

static inline SFIELD__IN_KERNEL void sfield__lanes_store(float *to, sfield__lanes a)
{
    SFIELD__EACH(SFIELD__INTEL(storeu_ps)(to + piece * SFIELD__WIDTH, a.v[piece]))
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_all(float x)
{
    sfield__lanes a;
    SFIELD__EACH(a.v[piece] = SFIELD__INTEL(set1_ps)(x))
    return a;
}

/* Comparisons with what is not a number are false, but for differ, which is true. */
static inline SFIELD__IN_KERNEL sfield__lane_mask sfield__lanes_greater(sfield__lanes a, sfield__lanes b)
{
    sfield__lane_mask m;
#if SFIELD__WIDTH == 16
    SFIELD__EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_GT_OQ))
#elif SFIELD__WIDTH == 8
    SFIELD__EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_GT_OQ))
#else
    SFIELD__EACH(m.v[piece] = _mm_cmpgt_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

static inline SFIELD__IN_KERNEL sfield__lane_mask sfield__lanes_at_least(sfield__lanes a, sfield__lanes b)
{
    sfield__lane_mask m;
#if SFIELD__WIDTH == 16
    SFIELD__EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_GE_OQ))
#elif SFIELD__WIDTH == 8
    SFIELD__EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_GE_OQ))
#else
    SFIELD__EACH(m.v[piece] = _mm_cmpge_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

static inline SFIELD__IN_KERNEL sfield__lane_mask sfield__lanes_differ(sfield__lanes a, sfield__lanes b)
{
    sfield__lane_mask m;
#if SFIELD__WIDTH == 16
    SFIELD__EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_NEQ_UQ))
#elif SFIELD__WIDTH == 8
    SFIELD__EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_NEQ_UQ))
#else
    SFIELD__EACH(m.v[piece] = _mm_cmpneq_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

/* Returns m ? a : b in each lane. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_select(sfield__lane_mask m, sfield__lanes a,
                                                 sfield__lanes b)
{
#if SFIELD__WIDTH == 16
    SFIELD__EACH(a.v[piece] = _mm512_mask_mov_ps(b.v[piece], m.v[piece], a.v[piece]))
#elif SFIELD__WIDTH == 8
    SFIELD__EACH(a.v[piece] = _mm256_blendv_ps(b.v[piece], a.v[piece], m.v[piece]))
#else
    SFIELD__EACH(a.v[piece] = _mm_or_ps(_mm_and_ps(m.v[piece], a.v[piece]), _mm_andnot_ps(m.v[piece], b.v[piece])))
#endif
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_add(sfield__lanes a, sfield__lanes b)
{
    SFIELD__EACH(a.v[piece] = SFIELD__INTEL(add_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_sub(sfield__lanes a, sfield__lanes b)
{
    SFIELD__EACH(a.v[piece] = SFIELD__INTEL(sub_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_mul(sfield__lanes a, sfield__lanes b)
{
    SFIELD__EACH(a.v[piece] = SFIELD__INTEL(mul_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_div(sfield__lanes a, sfield__lanes b)
{
    SFIELD__EACH(a.v[piece] = SFIELD__INTEL(div_ps)(a.v[piece], b.v[piece]))
    return a;
}

/* Returns a b + c. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_muladd(sfield__lanes a, sfield__lanes b, sfield__lanes c)
{
#if SFIELD__WIDTH > 4
    SFIELD__EACH(a.v[piece] = SFIELD__INTEL(fmadd_ps)(a.v[piece], b.v[piece], c.v[piece]))
#else
    SFIELD__EACH(a.v[piece] = _mm_add_ps(_mm_mul_ps(a.v[piece], b.v[piece]), c.v[piece]))
#endif
    return a;
}

/* Returns a > b ? a : b, so that b is the answer if one is not a number. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_max(sfield__lanes a, sfield__lanes b)
{
#if SFIELD__WIDTH == 16                           /* gcc 12 warns of what max without a mask calls */
    SFIELD__EACH(a.v[piece] = _mm512_maskz_max_ps((__mmask16)0xffff, a.v[piece], b.v[piece]))
#else
    SFIELD__EACH(a.v[piece] = SFIELD__INTEL(max_ps)(a.v[piece], b.v[piece]))
#endif
    return a;
}

/* Returns a < b ? a : b. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_min(sfield__lanes a, sfield__lanes b)
{
#if SFIELD__WIDTH == 16                           /* gcc 12 warns of what min without a mask calls */
    SFIELD__EACH(a.v[piece] = _mm512_maskz_min_ps((__mmask16)0xffff, a.v[piece], b.v[piece]))
#else
    SFIELD__EACH(a.v[piece] = SFIELD__INTEL(min_ps)(a.v[piece], b.v[piece]))
#endif
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_sqrt(sfield__lanes a)
{
#if SFIELD__WIDTH == 16
    SFIELD__EACH(a.v[piece] = _mm512_maskz_sqrt_ps((__mmask16)0xffff, a.v[piece]))
#else
    SFIELD__EACH(a.v[piece] = SFIELD__INTEL(sqrt_ps)(a.v[piece]))
#endif
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_abs(sfield__lanes a)
{
    SFIELD__EACH(a.v[piece] = SFIELD__INTEL(andnot_ps)(SFIELD__INTEL(set1_ps)(-0.0f), a.v[piece]))
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_negate(sfield__lanes a)
{
    SFIELD__EACH(a.v[piece] = SFIELD__INTEL(xor_ps)(SFIELD__INTEL(set1_ps)(-0.0f), a.v[piece]))
    return a;
}

/* Returns m ? a : 0. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_keep(sfield__lane_mask m, sfield__lanes a)
{
#if SFIELD__WIDTH == 16
    SFIELD__EACH(a.v[piece] = _mm512_maskz_mov_ps(m.v[piece], a.v[piece]))
#else
    SFIELD__EACH(a.v[piece] = SFIELD__INTEL(and_ps)(m.v[piece], a.v[piece]))
#endif
    return a;
}

/* Rounds towards 0. An int32_t must be able to hold each float. */
static inline SFIELD__IN_KERNEL sfield__lane_ints sfield__lanes_truncate(sfield__lanes a)
{
    sfield__lane_ints k;
#if SFIELD__WIDTH == 16
    SFIELD__EACH(k.v[piece] = _mm512_maskz_cvttps_epi32((__mmask16)0xffff, a.v[piece]))
#else
    SFIELD__EACH(k.v[piece] = SFIELD__INTEL(cvttps_epi32)(a.v[piece]))
#endif
    return k;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_of_ints(sfield__lane_ints k)
{
    sfield__lanes a;
#if SFIELD__WIDTH == 16
    SFIELD__EACH(a.v[piece] = _mm512_maskz_cvtepi32_ps((__mmask16)0xffff, k.v[piece]))
#else
    SFIELD__EACH(a.v[piece] = SFIELD__INTEL(cvtepi32_ps)(k.v[piece]))
#endif
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_of_shorts(const int16_t *from)
{
    sfield__lanes a;
#if SFIELD__WIDTH == 16
    const __mmask16 all = (__mmask16)0xffff;    /* gcc 12's conversions without a mask warn of themselves */
    SFIELD__EACH(
        __m256i k = _mm256_loadu_si256((const __m256i *)(const void *)(from + piece * SFIELD__WIDTH));
        a.v[piece] = _mm512_maskz_cvtepi32_ps(all, _mm512_maskz_cvtepi16_epi32(all, k)))
#elif SFIELD__WIDTH == 8
    SFIELD__EACH(
        __m128i k = _mm_loadu_si128((const __m128i *)(const void *)(from + piece * SFIELD__WIDTH));
        a.v[piece] = _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(k)))
#else
    SFIELD__EACH(
        __m128i k = _mm_loadl_epi64((const __m128i *)(const void *)(from + piece * SFIELD__WIDTH));
        a.v[piece] = _mm_cvtepi32_ps(_mm_srai_epi32(_mm_unpacklo_epi16(k, k), 16)))
#endif
    return a;
}

/* Returns from[k] for each lane's k. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_gather(const float *from, sfield__lane_ints k)
{
    sfield__lanes a;
#if SFIELD__WIDTH == 16
    float each[16];                             /* gcc 12's gather warns of itself */
    int32_t at[16];
    int l;
    SFIELD__EACH(
        _mm512_storeu_si512((void *)at, k.v[piece]);
        for (l = 0; l < 16; l++) each[l] = from[at[l]];
        a.v[piece] = _mm512_loadu_ps(each))
#elif SFIELD__WIDTH == 8
    SFIELD__EACH(a.v[piece] = _mm256_i32gather_ps(from, k.v[piece], 4))
#else
    int32_t at[4];
    SFIELD__EACH(
        _mm_storeu_si128((__m128i *)(void *)at, k.v[piece]);
        a.v[piece] = _mm_setr_ps(from[at[0]], from[at[1]], from[at[2]], from[at[3]]))
#endif
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lane_mask sfield__mask_and(sfield__lane_mask m, sfield__lane_mask n)
{
#if SFIELD__WIDTH == 16
    SFIELD__EACH(m.v[piece] = (__mmask16)(m.v[piece] & n.v[piece]))
#else
    SFIELD__EACH(m.v[piece] = SFIELD__INTEL(and_ps)(m.v[piece], n.v[piece]))
#endif
    return m;
}

static inline SFIELD__IN_KERNEL sfield__lane_mask sfield__mask_or(sfield__lane_mask m, sfield__lane_mask n)
{
#if SFIELD__WIDTH == 16
    SFIELD__EACH(m.v[piece] = (__mmask16)(m.v[piece] | n.v[piece]))
#else
    SFIELD__EACH(m.v[piece] = SFIELD__INTEL(or_ps)(m.v[piece], n.v[piece]))
#endif
    return m;
}

/* Returns the mask as bits: bit l is that of lane l. */
static inline SFIELD__IN_KERNEL uint32_t sfield__mask_bits(sfield__lane_mask m)
{
    uint32_t bits = 0;
#if SFIELD__WIDTH == 16
    SFIELD__EACH(bits |= (uint32_t)m.v[piece] << piece * SFIELD__WIDTH)
#else
    SFIELD__EACH(bits |= (uint32_t)SFIELD__INTEL(movemask_ps)(m.v[piece]) << piece * SFIELD__WIDTH)
#endif
    return bits;
}

static inline SFIELD__IN_KERNEL sfield__lane_mask sfield__mask_of_bits(uint32_t bits)
{
    sfield__lane_mask m;
#if SFIELD__WIDTH == 16
    SFIELD__EACH(m.v[piece] = (__mmask16)(bits >> piece * SFIELD__WIDTH))
#elif SFIELD__WIDTH == 8
    const __m256i each = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    SFIELD__EACH(
        __m256i k = _mm256_and_si256(_mm256_set1_epi32((int32_t)(bits >> piece * SFIELD__WIDTH)), each);
        m.v[piece] = _mm256_castsi256_ps(_mm256_cmpeq_epi32(k, each)))
#else
    const __m128i each = _mm_setr_epi32(1, 2, 4, 8);
    SFIELD__EACH(
        __m128i k = _mm_and_si128(_mm_set1_epi32((int32_t)(bits >> piece * SFIELD__WIDTH)), each);
        m.v[piece] = _mm_castsi128_ps(_mm_cmpeq_epi32(k, each)))
#endif
    return m;
}

static inline SFIELD__IN_KERNEL int sfield__mask_any(sfield__lane_mask m)
{
    int any = 0;
#if SFIELD__WIDTH == 16
    SFIELD__EACH(any |= m.v[piece])
#else
    SFIELD__EACH(any |= SFIELD__INTEL(movemask_ps)(m.v[piece]))
#endif
    return any != 0;
}

static inline SFIELD__IN_KERNEL sfield__lane_ints sfield__ints_load(const int32_t *from)
{
    sfield__lane_ints k;
#if SFIELD__WIDTH == 16
    SFIELD__EACH(k.v[piece] = _mm512_loadu_si512((const void *)(from + piece * SFIELD__WIDTH)))
#elif SFIELD__WIDTH == 8
    SFIELD__EACH(k.v[piece] = _mm256_loadu_si256((const __m256i *)(const void *)(from + piece * SFIELD__WIDTH)))
#else
    SFIELD__EACH(k.v[piece] = _mm_loadu_si128((const __m128i *)(const void *)(from + piece * SFIELD__WIDTH)))
#endif
    return k;
}

static inline SFIELD__IN_KERNEL void sfield__ints_store(int32_t *to, sfield__lane_ints k)
{
#if SFIELD__WIDTH == 16
    SFIELD__EACH(_mm512_storeu_si512((void *)(to + piece * SFIELD__WIDTH), k.v[piece]))
#elif SFIELD__WIDTH == 8
    SFIELD__EACH(_mm256_storeu_si256((__m256i *)(void *)(to + piece * SFIELD__WIDTH), k.v[piece]))
#else
    SFIELD__EACH(_mm_storeu_si128((__m128i *)(void *)(to + piece * SFIELD__WIDTH), k.v[piece]))
#endif
}

static inline SFIELD__IN_KERNEL sfield__lane_ints sfield__ints_all(int32_t x)
{
    sfield__lane_ints k;
    SFIELD__EACH(k.v[piece] = SFIELD__INTEL(set1_epi32)(x))
    return k;
}

static inline SFIELD__IN_KERNEL sfield__lane_mask sfield__ints_equal(sfield__lane_ints k, sfield__lane_ints n)
{
    sfield__lane_mask m;
#if SFIELD__WIDTH == 16
    SFIELD__EACH(m.v[piece] = _mm512_cmpeq_epi32_mask(k.v[piece], n.v[piece]))
#elif SFIELD__WIDTH == 8
    SFIELD__EACH(m.v[piece] = _mm256_castsi256_ps(_mm256_cmpeq_epi32(k.v[piece], n.v[piece])))
#else
    SFIELD__EACH(m.v[piece] = _mm_castsi128_ps(_mm_cmpeq_epi32(k.v[piece], n.v[piece])))
#endif
    return m;
}

#endif

/* ==== src/shared/simd_plain.h ==== */

/* unit simd_plain, needs simd_begin: lanes of NEON, WebAssembly and others, or floats one by one */

#if !SFIELD__SIMD_X86 && SFIELD__WIDTH <= 4

#if SFIELD__SIMD_VECTORS
typedef float sfield__piece __attribute__((vector_size(16)));
typedef int32_t sfield__piece_ints __attribute__((vector_size(16)));
typedef uint32_t sfield__piece_words __attribute__((vector_size(16)));
#else
typedef float sfield__piece;
typedef int32_t sfield__piece_ints;
typedef uint32_t sfield__piece_words;
#endif
typedef struct sfield__lanes { sfield__piece v[SFIELD__LANE_COUNT / SFIELD__WIDTH]; } sfield__lanes;
typedef struct sfield__lane_ints { sfield__piece_ints v[SFIELD__LANE_COUNT / SFIELD__WIDTH]; } sfield__lane_ints;
/* Lanes of 0 or -1. */
typedef struct sfield__lane_mask { sfield__piece_ints v[SFIELD__LANE_COUNT / SFIELD__WIDTH]; } sfield__lane_mask;

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_load(const float *from)
{
    sfield__lanes a;
    SFIELD__EACH(memcpy(&a.v[piece], from + piece * SFIELD__WIDTH, sizeof a.v[piece]))
    return a;
}

static inline SFIELD__IN_KERNEL void sfield__lanes_store(float *to, sfield__lanes a)
{
    SFIELD__EACH(memcpy(to + piece * SFIELD__WIDTH, &a.v[piece], sizeof a.v[piece]))
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_all(float x)
{
    sfield__lanes a;
#if SFIELD__SIMD_VECTORS
    const sfield__piece all = { x, x, x, x };
    SFIELD__EACH(a.v[piece] = all)
#else
    SFIELD__EACH(a.v[piece] = x)
#endif
    return a;
}

/* Comparisons with what is not a number are false, but for differ, which is true. */
static inline SFIELD__IN_KERNEL sfield__lane_mask sfield__lanes_greater(sfield__lanes a, sfield__lanes b)
{
    sfield__lane_mask m;
#if SFIELD__SIMD_VECTORS
    SFIELD__EACH(m.v[piece] = a.v[piece] > b.v[piece])
#else
    SFIELD__EACH(m.v[piece] = -(a.v[piece] > b.v[piece]))
#endif
    return m;
}

static inline SFIELD__IN_KERNEL sfield__lane_mask sfield__lanes_at_least(sfield__lanes a, sfield__lanes b)
{
    sfield__lane_mask m;
#if SFIELD__SIMD_VECTORS
    SFIELD__EACH(m.v[piece] = a.v[piece] >= b.v[piece])
#else
    SFIELD__EACH(m.v[piece] = -(a.v[piece] >= b.v[piece]))
#endif
    return m;
}

static inline SFIELD__IN_KERNEL sfield__lane_mask sfield__lanes_differ(sfield__lanes a, sfield__lanes b)
{
    sfield__lane_mask m;
#if SFIELD__SIMD_VECTORS
    SFIELD__EACH(m.v[piece] = a.v[piece] != b.v[piece])
#else
    SFIELD__EACH(m.v[piece] = -(a.v[piece] != b.v[piece]))
#endif
    return m;
}

/* Returns m ? a : b in each lane. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_select(sfield__lane_mask m, sfield__lanes a,
                                                 sfield__lanes b)
{
#if SFIELD__SIMD_VECTORS
    SFIELD__EACH(a.v[piece] = (sfield__piece)((m.v[piece] & (sfield__piece_ints)a.v[piece]) |
                                  (~m.v[piece] & (sfield__piece_ints)b.v[piece])))
#else
    SFIELD__EACH(a.v[piece] = m.v[piece] ? a.v[piece] : b.v[piece])
#endif
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_add(sfield__lanes a, sfield__lanes b)
{
    SFIELD__EACH(a.v[piece] = a.v[piece] + b.v[piece])
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_sub(sfield__lanes a, sfield__lanes b)
{
    SFIELD__EACH(a.v[piece] = a.v[piece] - b.v[piece])
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_mul(sfield__lanes a, sfield__lanes b)
{
    SFIELD__EACH(a.v[piece] = a.v[piece] * b.v[piece])
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_div(sfield__lanes a, sfield__lanes b)
{
    SFIELD__EACH(a.v[piece] = a.v[piece] / b.v[piece])
    return a;
}

/* Returns a b + c. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_muladd(sfield__lanes a, sfield__lanes b, sfield__lanes c)
{
    SFIELD__EACH(a.v[piece] = a.v[piece] * b.v[piece] + c.v[piece])
    return a;
}

/* Returns a > b ? a : b, so that b is the answer if one is not a number. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_max(sfield__lanes a, sfield__lanes b)
{
    return sfield__lanes_select(sfield__lanes_greater(a, b), a, b);
}

/* Returns a < b ? a : b. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_min(sfield__lanes a, sfield__lanes b)
{
    return sfield__lanes_select(sfield__lanes_greater(b, a), a, b);
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_sqrt(sfield__lanes a)
{
#if SFIELD__SIMD_VECTORS
#if defined(__aarch64__) && !defined(SFIELD__NO_SIMD)
    SFIELD__EACH(a.v[piece] = (sfield__piece)vsqrtq_f32((float32x4_t)a.v[piece]))
#elif defined(__wasm_simd128__) && !defined(SFIELD__NO_SIMD)
    SFIELD__EACH(a.v[piece] = (sfield__piece)wasm_f32x4_sqrt((v128_t)a.v[piece]))
#else
    int k;
    SFIELD__EACH(for (k = 0; k < 4; k++) a.v[piece][k] = sqrtf(a.v[piece][k]))
#endif
#else
    SFIELD__EACH(a.v[piece] = sqrtf(a.v[piece]))
#endif
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_abs(sfield__lanes a)
{
#if SFIELD__SIMD_VECTORS
    const int32_t b = 0x7fffffff;
    const sfield__piece_ints bits = { b, b, b, b };
    SFIELD__EACH(a.v[piece] = (sfield__piece)((sfield__piece_ints)a.v[piece] & bits))
#else
    SFIELD__EACH(a.v[piece] = fabsf(a.v[piece]))
#endif
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_negate(sfield__lanes a)
{
    SFIELD__EACH(a.v[piece] = -a.v[piece])
    return a;
}

/* Returns m ? a : 0. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_keep(sfield__lane_mask m, sfield__lanes a)
{
#if SFIELD__SIMD_VECTORS
    SFIELD__EACH(a.v[piece] = (sfield__piece)(m.v[piece] & (sfield__piece_ints)a.v[piece]))
#else
    SFIELD__EACH(a.v[piece] = m.v[piece] ? a.v[piece] : 0.0f)
#endif
    return a;
}

/* Rounds towards 0. An int32_t must be able to hold each float. */
static inline SFIELD__IN_KERNEL sfield__lane_ints sfield__lanes_truncate(sfield__lanes a)
{
    sfield__lane_ints k;
#if SFIELD__SIMD_VECTORS
    SFIELD__EACH(k.v[piece] = __builtin_convertvector(a.v[piece], sfield__piece_ints))
#else
    SFIELD__EACH(k.v[piece] = (int32_t)a.v[piece])
#endif
    return k;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_of_ints(sfield__lane_ints k)
{
    sfield__lanes a;
#if SFIELD__SIMD_VECTORS           /* + 0: of 0 that was truncated from -0.5, gcc 12 makes -0 for NEON */
    SFIELD__EACH(a.v[piece] = __builtin_convertvector(k.v[piece], sfield__piece) + 0.0f)
#else
    SFIELD__EACH(a.v[piece] = (float)k.v[piece])
#endif
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_of_shorts(const int16_t *from)
{
    sfield__lanes a;
#if SFIELD__SIMD_VECTORS
    SFIELD__EACH(
        const int16_t *k = from + piece * SFIELD__WIDTH;
        const sfield__piece four = { (float)k[0], (float)k[1], (float)k[2], (float)k[3] };
        a.v[piece] = four)
#else
    SFIELD__EACH(a.v[piece] = (float)from[piece])
#endif
    return a;
}

/* Returns from[k] for each lane's k. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_gather(const float *from, sfield__lane_ints k)
{
    sfield__lanes a;
#if SFIELD__SIMD_VECTORS
    SFIELD__EACH(
        const sfield__piece_ints at = k.v[piece];
        const sfield__piece four = { from[at[0]], from[at[1]], from[at[2]], from[at[3]] };
        a.v[piece] = four)
#else
    SFIELD__EACH(a.v[piece] = from[k.v[piece]])
#endif
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lane_mask sfield__mask_and(sfield__lane_mask m, sfield__lane_mask n)
{
    SFIELD__EACH(m.v[piece] = m.v[piece] & n.v[piece])
    return m;
}

static inline SFIELD__IN_KERNEL sfield__lane_mask sfield__mask_or(sfield__lane_mask m, sfield__lane_mask n)
{
    SFIELD__EACH(m.v[piece] = m.v[piece] | n.v[piece])
    return m;
}

/* Returns the mask as bits: bit l is that of lane l. */
static inline SFIELD__IN_KERNEL uint32_t sfield__mask_bits(sfield__lane_mask m)
{
    uint32_t bits = 0;
#if SFIELD__SIMD_VECTORS
    int k;
    SFIELD__EACH(for (k = 0; k < 4; k++) bits |= ((uint32_t)m.v[piece][k] & 1u) << (piece * SFIELD__WIDTH + k))
#else
    SFIELD__EACH(bits |= ((uint32_t)m.v[piece] & 1u) << piece)
#endif
    return bits;
}

static inline SFIELD__IN_KERNEL sfield__lane_mask sfield__mask_of_bits(uint32_t bits)
{
    sfield__lane_mask m;
#if SFIELD__SIMD_VECTORS
    const sfield__piece_ints each = { 1, 2, 4, 8 };
    SFIELD__EACH(
        const int32_t own = (int32_t)(bits >> piece * SFIELD__WIDTH & 15u);
        const sfield__piece_ints all = { own, own, own, own };
        m.v[piece] = (all & each) == each)
#else
    SFIELD__EACH(m.v[piece] = -(int32_t)(bits >> piece & 1u))
#endif
    return m;
}

static inline SFIELD__IN_KERNEL int sfield__mask_any(sfield__lane_mask m)
{
    int any = 0;
#if SFIELD__SIMD_VECTORS
    SFIELD__EACH(any |= m.v[piece][0] | m.v[piece][1] | m.v[piece][2] | m.v[piece][3])
#else
    SFIELD__EACH(any |= m.v[piece])
#endif
    return any != 0;
}

static inline SFIELD__IN_KERNEL sfield__lane_ints sfield__ints_load(const int32_t *from)
{
    sfield__lane_ints k;
    SFIELD__EACH(memcpy(&k.v[piece], from + piece * SFIELD__WIDTH, sizeof k.v[piece]))
    return k;
}

static inline SFIELD__IN_KERNEL void sfield__ints_store(int32_t *to, sfield__lane_ints k)
{
    SFIELD__EACH(memcpy(to + piece * SFIELD__WIDTH, &k.v[piece], sizeof k.v[piece]))
}

static inline SFIELD__IN_KERNEL sfield__lane_ints sfield__ints_all(int32_t x)
{
    sfield__lane_ints k;
#if SFIELD__SIMD_VECTORS
    const sfield__piece_ints all = { x, x, x, x };
    SFIELD__EACH(k.v[piece] = all)
#else
    SFIELD__EACH(k.v[piece] = x)
#endif
    return k;
}

static inline SFIELD__IN_KERNEL sfield__lane_mask sfield__ints_equal(sfield__lane_ints k, sfield__lane_ints n)
{
    sfield__lane_mask m;
#if SFIELD__SIMD_VECTORS
    SFIELD__EACH(m.v[piece] = k.v[piece] == n.v[piece])
#else
    SFIELD__EACH(m.v[piece] = -(k.v[piece] == n.v[piece]))
#endif
    return m;
}

#endif

/* ==== src/shared/simd_order.h ==== */

/* unit simd_order, needs simd_begin: sixteen lanes in another order, bytes as lanes, 8 x 8 floats
   transposed */

#define sfield__lanes_of_bytes SFIELD__NAME_IN_SET(sfield__lanes_of_bytes, SFIELD__SET)
#define sfield__lanes_load_halves SFIELD__NAME_IN_SET(sfield__lanes_load_halves, SFIELD__SET)
#define sfield__lanes_load_fours SFIELD__NAME_IN_SET(sfield__lanes_load_fours, SFIELD__SET)
#define sfield__lanes_swap_ones SFIELD__NAME_IN_SET(sfield__lanes_swap_ones, SFIELD__SET)
#define sfield__lanes_swap_twos SFIELD__NAME_IN_SET(sfield__lanes_swap_twos, SFIELD__SET)
#define sfield__transpose4 SFIELD__NAME_IN_SET(sfield__transpose4, SFIELD__SET)
#define sfield__transpose8 SFIELD__NAME_IN_SET(sfield__transpose8, SFIELD__SET)

/* Returns sixteen bytes as floats, 0..255. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_of_bytes(const uint8_t *from)
{
    sfield__lanes a;
#if SFIELD__WIDTH == 16
    const __mmask16 all = (__mmask16)0xffff;    /* gcc 12's conversions without a mask warn of themselves */
    const __m128i k = _mm_loadu_si128((const __m128i *)(const void *)from);
    SFIELD__EACH(a.v[piece] = _mm512_maskz_cvtepi32_ps(all, _mm512_maskz_cvtepu8_epi32(all, k)))
#elif SFIELD__WIDTH == 8
    SFIELD__EACH(
        const __m128i k = _mm_loadl_epi64((const __m128i *)(const void *)(from + piece * SFIELD__WIDTH));
        a.v[piece] = _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(k)))
#elif SFIELD__SIMD_X86
    const __m128i zero = _mm_setzero_si128(), k = _mm_loadu_si128((const __m128i *)(const void *)from);
    const __m128i low = _mm_unpacklo_epi8(k, zero), high = _mm_unpackhi_epi8(k, zero);
    a.v[0] = _mm_cvtepi32_ps(_mm_unpacklo_epi16(low, zero));
    a.v[1] = _mm_cvtepi32_ps(_mm_unpackhi_epi16(low, zero));
    a.v[2] = _mm_cvtepi32_ps(_mm_unpacklo_epi16(high, zero));
    a.v[3] = _mm_cvtepi32_ps(_mm_unpackhi_epi16(high, zero));
#elif SFIELD__SIMD_VECTORS
    SFIELD__EACH(
        const uint8_t *k = from + piece * SFIELD__WIDTH;
        const sfield__piece four = { (float)k[0], (float)k[1], (float)k[2], (float)k[3] };
        a.v[piece] = four)
#else
    SFIELD__EACH(a.v[piece] = (float)from[piece])
#endif
    return a;
}

/* Returns eight floats from each of two places, those of `first` in lanes 0..7. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_load_halves(const float *first, const float *second)
{
    sfield__lanes a;
#if SFIELD__WIDTH == 16
    const __m512 low = _mm512_castps256_ps512(_mm256_loadu_ps(first));
    SFIELD__EACH(a.v[piece] = _mm512_maskz_insertf32x8((__mmask16)0xffff, low, _mm256_loadu_ps(second), 1))
#else
    SFIELD__EACH(
        const float *from = piece * SFIELD__WIDTH < 8 ? first + piece * SFIELD__WIDTH
                                                : second + piece * SFIELD__WIDTH - 8;
        memcpy(&a.v[piece], from, sizeof a.v[piece]))
#endif
    return a;
}

/* Returns four floats, `stride` apart, each in four lanes: the first in lanes 0..3. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_load_fours(const float *from, size_t stride)
{
    sfield__lanes a;
#if SFIELD__WIDTH > 4
    const __m256 low = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_set1_ps(from[0])),
                                            _mm_set1_ps(from[stride]), 1);
    const __m256 high = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_set1_ps(from[2 * stride])),
                                             _mm_set1_ps(from[3 * stride]), 1);
#endif
#if SFIELD__WIDTH == 16
    a.v[0] = _mm512_maskz_insertf32x8((__mmask16)0xffff, _mm512_castps256_ps512(low), high, 1);
#elif SFIELD__WIDTH == 8
    a.v[0] = low;
    a.v[1] = high;
#elif SFIELD__SIMD_X86
    SFIELD__EACH(a.v[piece] = _mm_set1_ps(from[piece * stride]))
#elif SFIELD__SIMD_VECTORS
    SFIELD__EACH(
        const float x = from[piece * stride];
        const sfield__piece four = { x, x, x, x };
        a.v[piece] = four)
#else
    SFIELD__EACH(a.v[piece] = from[(size_t)piece / 4 * stride])
#endif
    return a;
}

/* Returns lanes 1 0 3 2, 5 4 7 6, ... */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_swap_ones(sfield__lanes a)
{
    sfield__lanes b;
#if SFIELD__WIDTH == 16
    SFIELD__EACH(b.v[piece] = _mm512_maskz_permute_ps((__mmask16)0xffff, a.v[piece], 0xb1))
#elif SFIELD__WIDTH == 8
    SFIELD__EACH(b.v[piece] = _mm256_permute_ps(a.v[piece], 0xb1))
#elif SFIELD__SIMD_X86
    SFIELD__EACH(b.v[piece] = _mm_shuffle_ps(a.v[piece], a.v[piece], 0xb1))
#elif SFIELD__SIMD_VECTORS
    SFIELD__EACH(
        const sfield__piece four = { a.v[piece][1], a.v[piece][0], a.v[piece][3], a.v[piece][2] };
        b.v[piece] = four)
#else
    SFIELD__EACH(b.v[piece] = a.v[piece ^ 1])
#endif
    return b;
}

/* Returns lanes 2 3 0 1, 6 7 4 5, ... */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_swap_twos(sfield__lanes a)
{
    sfield__lanes b;
#if SFIELD__WIDTH == 16
    SFIELD__EACH(b.v[piece] = _mm512_maskz_permute_ps((__mmask16)0xffff, a.v[piece], 0x4e))
#elif SFIELD__WIDTH == 8
    SFIELD__EACH(b.v[piece] = _mm256_permute_ps(a.v[piece], 0x4e))
#elif SFIELD__SIMD_X86
    SFIELD__EACH(b.v[piece] = _mm_shuffle_ps(a.v[piece], a.v[piece], 0x4e))
#elif SFIELD__SIMD_VECTORS
    SFIELD__EACH(
        const sfield__piece four = { a.v[piece][2], a.v[piece][3], a.v[piece][0], a.v[piece][1] };
        b.v[piece] = four)
#else
    SFIELD__EACH(b.v[piece] = a.v[piece ^ 2])
#endif
    return b;
}

#if SFIELD__WIDTH <= 4
/* Writes the columns of 4 x 4 floats as rows. */
static inline SFIELD__IN_KERNEL void sfield__transpose4(const float *in, size_t in_stride, float *out,
                                            size_t out_stride)
{
#if SFIELD__SIMD_X86
    const __m128 a = _mm_loadu_ps(in), b = _mm_loadu_ps(in + in_stride);
    const __m128 c = _mm_loadu_ps(in + 2 * in_stride), d = _mm_loadu_ps(in + 3 * in_stride);
    const __m128 ab = _mm_unpacklo_ps(a, b), cd = _mm_unpacklo_ps(c, d);
    const __m128 ba = _mm_unpackhi_ps(a, b), dc = _mm_unpackhi_ps(c, d);
    _mm_storeu_ps(out, _mm_movelh_ps(ab, cd));
    _mm_storeu_ps(out + out_stride, _mm_movehl_ps(cd, ab));
    _mm_storeu_ps(out + 2 * out_stride, _mm_movelh_ps(ba, dc));
    _mm_storeu_ps(out + 3 * out_stride, _mm_movehl_ps(dc, ba));
#else
    size_t i;
    for (i = 0; i < 4; i++, out += out_stride) {
        out[0] = in[i];
        out[1] = in[in_stride + i];
        out[2] = in[2 * in_stride + i];
        out[3] = in[3 * in_stride + i];
    }
#endif
}
#endif

/* Writes the columns of 8 x 8 floats as rows. */
static inline SFIELD__IN_KERNEL void sfield__transpose8(const float *in, size_t in_stride, float *out,
                                            size_t out_stride)
{
    size_t i;
#if SFIELD__WIDTH > 4
    __m256 r[8], t[8];
    for (i = 0; i < 8; i++) r[i] = _mm256_loadu_ps(in + i * in_stride);
    for (i = 0; i < 4; i++) {
        t[2 * i] = _mm256_unpacklo_ps(r[2 * i], r[2 * i + 1]);
        t[2 * i + 1] = _mm256_unpackhi_ps(r[2 * i], r[2 * i + 1]);
    }
    for (i = 0; i < 2; i++) {
        r[4 * i] = _mm256_shuffle_ps(t[4 * i], t[4 * i + 2], 0x44);
        r[4 * i + 1] = _mm256_shuffle_ps(t[4 * i], t[4 * i + 2], 0xee);
        r[4 * i + 2] = _mm256_shuffle_ps(t[4 * i + 1], t[4 * i + 3], 0x44);
        r[4 * i + 3] = _mm256_shuffle_ps(t[4 * i + 1], t[4 * i + 3], 0xee);
    }
    for (i = 0; i < 4; i++) {
        _mm256_storeu_ps(out + out_stride * i, _mm256_permute2f128_ps(r[i], r[4 + i], 0x20));
        _mm256_storeu_ps(out + out_stride * (i + 4), _mm256_permute2f128_ps(r[i], r[4 + i], 0x31));
    }
#else
    for (i = 0; i < 4; i++) {
        const size_t x = 4 * (i & 1), y = 4 * (i >> 1);
        sfield__transpose4(in + y * in_stride + x, in_stride, out + x * out_stride + y, out_stride);
    }
#endif
}

/* ==== src/shared/simd_ints.h ==== */

/* unit simd_ints, needs simd_begin bits: whole numbers in lanes, lanes of a mask in a row, single bits */
#define sfield__first_bit SFIELD__NAME_IN_SET(sfield__first_bit, SFIELD__SET)

/* Returns the number of the lowest set bit; bits is not 0. */
static inline SFIELD__IN_KERNEL uint32_t sfield__first_bit(uint32_t bits)
{
#if SFIELD__WIDTH > 4
    return _tzcnt_u32(bits);
#elif defined(__GNUC__) && !defined(__TINYC__)
    return (uint32_t)__builtin_ctz(bits);
#else
    return sfield__popcount(~bits & (bits - 1u));
#endif
}

/* ==== src/shared/simd_lanes3.h ==== */

/* unit simd_lanes3, needs simd_begin: vectors of three in lanes */

typedef struct sfield__lanes3 { sfield__lanes x, y, z; } sfield__lanes3;

static inline SFIELD__IN_KERNEL sfield__lanes3 sfield__lanes3_load(const float *x, const float *y, const float *z)
{
    sfield__lanes3 a;
    a.x = sfield__lanes_load(x);
    a.y = sfield__lanes_load(y);
    a.z = sfield__lanes_load(z);
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes3 sfield__lanes3_all(float x, float y, float z)
{
    sfield__lanes3 a;
    a.x = sfield__lanes_all(x);
    a.y = sfield__lanes_all(y);
    a.z = sfield__lanes_all(z);
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes3 sfield__lanes3_sub(sfield__lanes3 a, sfield__lanes3 b)
{
    a.x = sfield__lanes_sub(a.x, b.x);
    a.y = sfield__lanes_sub(a.y, b.y);
    a.z = sfield__lanes_sub(a.z, b.z);
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes3 sfield__lanes3_scale(sfield__lanes3 a, sfield__lanes s)
{
    a.x = sfield__lanes_mul(a.x, s);
    a.y = sfield__lanes_mul(a.y, s);
    a.z = sfield__lanes_mul(a.z, s);
    return a;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes3_dot(sfield__lanes3 a, sfield__lanes3 b)
{
    return sfield__lanes_add(sfield__lanes_add(sfield__lanes_mul(a.x, b.x), sfield__lanes_mul(a.y, b.y)),
                       sfield__lanes_mul(a.z, b.z));
}

/* ==== src/shadowfield/kernels_views.h ==== */

/* ---- kernels: sixteen triangles seen from an eye ---- */

#define sfield__trio SFIELD__NAME_IN_SET(sfield__trio, SFIELD__SET)
#define sfield__sides SFIELD__NAME_IN_SET(sfield__sides, SFIELD__SET)
#define sfield__boxes SFIELD__NAME_IN_SET(sfield__boxes, SFIELD__SET)
#define sfield__edge SFIELD__NAME_IN_SET(sfield__edge, SFIELD__SET)
#define sfield__cones SFIELD__NAME_IN_SET(sfield__cones, SFIELD__SET)
#define sfield__lanes3_cross SFIELD__NAME_IN_SET(sfield__lanes3_cross, SFIELD__SET)
#define sfield__lanes3_add SFIELD__NAME_IN_SET(sfield__lanes3_add, SFIELD__SET)
#define sfield__lanes_whole SFIELD__NAME_IN_SET(sfield__lanes_whole, SFIELD__SET)
#define sfield__lanes_up SFIELD__NAME_IN_SET(sfield__lanes_up, SFIELD__SET)
#define sfield__lanes_min3 SFIELD__NAME_IN_SET(sfield__lanes_min3, SFIELD__SET)
#define sfield__lanes_max3 SFIELD__NAME_IN_SET(sfield__lanes_max3, SFIELD__SET)
#define sfield__load_trio SFIELD__NAME_IN_SET(sfield__load_trio, SFIELD__SET)
#define sfield__pick_trio SFIELD__NAME_IN_SET(sfield__pick_trio, SFIELD__SET)
#define sfield__sides_of SFIELD__NAME_IN_SET(sfield__sides_of, SFIELD__SET)
#define sfield__on_one_face SFIELD__NAME_IN_SET(sfield__on_one_face, SFIELD__SET)
#define sfield__turn_to_sides SFIELD__NAME_IN_SET(sfield__turn_to_sides, SFIELD__SET)
#define sfield__turn_to_face SFIELD__NAME_IN_SET(sfield__turn_to_face, SFIELD__SET)
#define sfield__round_boxes SFIELD__NAME_IN_SET(sfield__round_boxes, SFIELD__SET)
#define sfield__edge_between SFIELD__NAME_IN_SET(sfield__edge_between, SFIELD__SET)
#define sfield__find_cones SFIELD__NAME_IN_SET(sfield__find_cones, SFIELD__SET)
#define sfield__cut_rows SFIELD__NAME_IN_SET(sfield__cut_rows, SFIELD__SET)
#define sfield__store_planes SFIELD__NAME_IN_SET(sfield__store_planes, SFIELD__SET)
#define sfield__store_trio SFIELD__NAME_IN_SET(sfield__store_trio, SFIELD__SET)
#define sfield__draw_rows SFIELD__NAME_IN_SET(sfield__draw_rows, SFIELD__SET)
#define sfield__draw_across SFIELD__NAME_IN_SET(sfield__draw_across, SFIELD__SET)
#define sfield__draw_triangles SFIELD__NAME_IN_SET(sfield__draw_triangles, SFIELD__SET)

/* SFIELD__IN_VIEW stands after `static`, before a function that these kernels call. SSE2 beside AVX2 is for
   old processors: calls in place of copies spare compilers a fifteenth of their time for the whole header,
   and make a build two fifths longer there. */
#undef SFIELD__IN_VIEW
#if defined(__GNUC__) && SFIELD__SIMD_SETS && SFIELD__WIDTH == 4
#define SFIELD__IN_VIEW __attribute__((noinline)) SFIELD__KERNEL
#else
#define SFIELD__IN_VIEW inline SFIELD__IN_KERNEL
#endif

typedef struct sfield__trio { sfield__lanes3 a, b, c; } sfield__trio;   /* the corners of triangles */

static SFIELD__IN_VIEW sfield__lanes3 sfield__lanes3_cross(sfield__lanes3 a, sfield__lanes3 b)
{
    sfield__lanes3 n;
    n.x = sfield__lanes_sub(sfield__lanes_mul(a.y, b.z), sfield__lanes_mul(a.z, b.y));
    n.y = sfield__lanes_sub(sfield__lanes_mul(a.z, b.x), sfield__lanes_mul(a.x, b.z));
    n.z = sfield__lanes_sub(sfield__lanes_mul(a.x, b.y), sfield__lanes_mul(a.y, b.x));
    return n;
}

static SFIELD__IN_VIEW sfield__lanes3 sfield__lanes3_add(sfield__lanes3 a, sfield__lanes3 b)
{
    a.x = sfield__lanes_add(a.x, b.x);
    a.y = sfield__lanes_add(a.y, b.y);
    a.z = sfield__lanes_add(a.z, b.z);
    return a;
}

/* Rounds floats from 0 to 2^31 down; sfield__lanes_up rounds them up. */
static SFIELD__IN_VIEW sfield__lanes sfield__lanes_whole(sfield__lanes a)
{
    return sfield__lanes_of_ints(sfield__lanes_truncate(a));
}

static SFIELD__IN_VIEW sfield__lanes sfield__lanes_up(sfield__lanes a)
{
    const sfield__lanes whole = sfield__lanes_whole(a);
    const sfield__lanes one = sfield__lanes_all(1);
    return sfield__lanes_add(whole, sfield__lanes_keep(sfield__lanes_greater(a, whole), one));
}

static SFIELD__IN_VIEW sfield__lanes sfield__lanes_min3(sfield__lanes a, sfield__lanes b,
                                                        sfield__lanes c)
{
    return sfield__lanes_min(sfield__lanes_min(a, b), c);
}

static SFIELD__IN_VIEW sfield__lanes sfield__lanes_max3(sfield__lanes a, sfield__lanes b,
                                                        sfield__lanes c)
{
    return sfield__lanes_max(sfield__lanes_max(a, b), c);
}

/* Loads the corners of sixteen triangles from planes that are `room` apart, about an eye. */
static SFIELD__IN_VIEW sfield__trio sfield__load_trio(const float *from, size_t room,
                                                      const float *eye)
{
    const sfield__lanes3 origin = sfield__lanes3_all(eye[0], eye[1], eye[2]);
    sfield__trio t;
    t.a = sfield__lanes3_sub(sfield__lanes3_load(from, from + room, from + 2 * room), origin);
    from += 3 * room;
    t.b = sfield__lanes3_sub(sfield__lanes3_load(from, from + room, from + 2 * room), origin);
    from += 3 * room;
    t.c = sfield__lanes3_sub(sfield__lanes3_load(from, from + room, from + 2 * room), origin);
    return t;
}

/* Loads triangles by their numbers, sixteen of them. */
static SFIELD__IN_VIEW sfield__trio sfield__pick_trio(const float *from, size_t room,
                                                      const float *eye, const uint32_t *number)
{
    float all[9 * 16];
    uint32_t k, l;
    for (k = 0; k < 9; k++)
        for (l = 0; l < 16; l++) all[16 * k + l] = from[k * room + number[l]];
    return sfield__load_trio(all, 16, eye);
}

/* The faces that corners lie on, as sfield__face_of finds them. */
typedef struct sfield__sides {
    sfield__lane_mask x, y;             /* the axis; z where neither */
    sfield__lane_mask front;            /* of the axis: on its positive side */
    sfield__lanes     number;           /* 0..5 */
} sfield__sides;

static SFIELD__IN_VIEW sfield__sides sfield__sides_of(sfield__lanes3 p)
{
    const sfield__lanes x = sfield__lanes_abs(p.x), y = sfield__lanes_abs(p.y), z = sfield__lanes_abs(p.z);
    const sfield__lanes none = sfield__lanes_all(0);
    sfield__sides s;
    s.x = sfield__mask_and(sfield__lanes_at_least(x, y), sfield__lanes_at_least(x, z));
    s.y = sfield__mask_and(sfield__lanes_greater(y, x), sfield__lanes_at_least(y, z));
    s.front = sfield__lanes_greater(
        sfield__lanes_select(s.x, p.x, sfield__lanes_select(s.y, p.y, p.z)), none);
    s.number = sfield__lanes_select(s.x, none, sfield__lanes_select(s.y, sfield__lanes_all(2),
                                                                    sfield__lanes_all(4)));
    s.number = sfield__lanes_add(s.number, sfield__lanes_select(s.front, none, sfield__lanes_all(1)));
    return s;
}

/* Returns which triangles have their three corners on the face of the first, as bits. */
static SFIELD__IN_VIEW uint32_t sfield__on_one_face(const sfield__trio *t, sfield__lanes number)
{
    const sfield__lanes b = sfield__sides_of(t->b).number, c = sfield__sides_of(t->c).number;
    return ~sfield__mask_bits(sfield__mask_or(sfield__lanes_differ(number, b),
                                              sfield__lanes_differ(number, c))) & 0xffffu;
}

/* Turns the corners of triangles as sfield__to_face does, each to a face of its own, on which the corners
   lie: the part along the axis is its absolute value. */
static SFIELD__IN_VIEW sfield__trio sfield__turn_to_sides(const sfield__trio *t,
                                                          const sfield__sides *on)
{
    const sfield__lanes one = sfield__lanes_all(1), minus = sfield__lanes_all(-1);
    const sfield__lanes front = sfield__lanes_select(on->front, one, minus);
    const sfield__lanes back = sfield__lanes_select(on->front, minus, one);
    const sfield__lanes s = sfield__lanes_select(on->x, back, sfield__lanes_select(on->y, one, front));
    const sfield__lanes u = sfield__lanes_select(on->y, front, minus);
    sfield__trio q;
#define SFIELD__TURN(p)                                                                                    \
    q.p.x = sfield__lanes_mul(s, sfield__lanes_select(on->x, t->p.z, t->p.x));                             \
    q.p.y = sfield__lanes_mul(u, sfield__lanes_select(on->y, t->p.z, t->p.y));                             \
    q.p.z = sfield__lanes_abs(                                                                             \
        sfield__lanes_select(on->x, t->p.x, sfield__lanes_select(on->y, t->p.y, t->p.z)))
    SFIELD__TURN(a);
    SFIELD__TURN(b);
    SFIELD__TURN(c);
#undef SFIELD__TURN
    return q;
}

static SFIELD__IN_VIEW sfield__lanes3 sfield__turn_to_face(uint32_t face, sfield__lanes3 p)
{
    sfield__lanes3 q = p;
    const sfield__lanes3 back = sfield__lanes3_scale(p, sfield__lanes_all(-1));
    switch (face) {
    case 0: q.x = back.z, q.y = back.y, q.z = p.x; break;
    case 1: q.x = p.z, q.y = back.y, q.z = back.x; break;
    case 2: q.y = p.z, q.z = p.y; break;
    case 3: q.y = back.z, q.z = back.y; break;
    case 4: q.y = back.y; break;
    default: q = back; break;
    }
    return q;
}

/* Places of samples, whole numbers: those that may lie inside triangles. */
typedef struct sfield__boxes {
    sfield__lanes     x0, y0, x1, y1;
    sfield__lane_mask used;             /* lanes with one sample at least */
} sfield__boxes;

/* Rounds boxes to samples, outwards by a little. */
static SFIELD__IN_VIEW sfield__boxes sfield__round_boxes(sfield__boxes b, float width)
{
    const sfield__lanes none = sfield__lanes_all(0), most = sfield__lanes_all(width - 1);
    const sfield__lanes a_little = sfield__lanes_all(0.01f);
    b.x0 = sfield__lanes_max(sfield__lanes_sub(b.x0, a_little), none);
    b.y0 = sfield__lanes_max(sfield__lanes_sub(b.y0, a_little), none);
    b.x1 = sfield__lanes_min(sfield__lanes_add(b.x1, a_little), most);
    b.y1 = sfield__lanes_min(sfield__lanes_add(b.y1, a_little), most);
    b.used = sfield__mask_and(sfield__lanes_at_least(b.x1, b.x0), sfield__lanes_at_least(b.y1, b.y0));
    b.x0 = sfield__lanes_up(sfield__lanes_keep(b.used, b.x0));
    b.y0 = sfield__lanes_up(sfield__lanes_keep(b.used, b.y0));
    b.x1 = sfield__lanes_whole(sfield__lanes_keep(b.used, b.x1));
    b.y1 = sfield__lanes_whole(sfield__lanes_keep(b.used, b.y1));
    b.used = sfield__mask_and(b.used, sfield__lanes_at_least(b.x1, b.x0));
    b.used = sfield__mask_and(b.used, sfield__lanes_at_least(b.y1, b.y0));
    return b;
}

/* Edges: c.x s + c.y t + c.z >= 0 on the inner side. */
typedef struct sfield__edge {
    sfield__lanes3    c;
    sfield__lanes     inverse;          /* 1 / c.x */
    sfield__lane_mask left, right, flat;    /* of the samples inside: where the edge is; c.x = 0 */
} sfield__edge;

typedef struct sfield__cones {
    sfield__edge a, b, c;
    sfield__lanes det;                  /* > 0: counter-clockwise for the eye */
} sfield__cones;

static SFIELD__IN_VIEW void sfield__edge_between(sfield__edge *e, sfield__lanes turn)
{
    const sfield__lanes none = sfield__lanes_all(0), one = sfield__lanes_all(1);
    e->c = sfield__lanes3_scale(e->c, turn);
    e->inverse = sfield__lanes_keep(sfield__lanes_differ(e->c.x, none), sfield__lanes_div(one, e->c.x));
    e->left = sfield__lanes_greater(e->c.x, none);
    e->right = sfield__lanes_greater(none, e->c.x);
    e->flat = sfield__lanes_greater(
        sfield__lanes_select(sfield__mask_or(e->left, e->right), none, one), none);
}

/* Describes triangles as the cones from the eye through their edges. So nothing is clipped or divided, and
   an edge that two triangles share has the same numbers in both but for their sign: no sample falls between
   them. Returns, as bits, those that are not seen from their edge. */
static SFIELD__IN_VIEW uint32_t sfield__find_cones(const sfield__trio *q, sfield__cones *e)
{
    const sfield__lanes none = sfield__lanes_all(0);
    sfield__lane_mask front, back;
    sfield__lanes turn;
    e->a.c = sfield__lanes3_cross(q->a, q->b);
    e->b.c = sfield__lanes3_cross(q->b, q->c);
    e->c.c = sfield__lanes3_cross(q->c, q->a);
    e->det = sfield__lanes3_dot(q->c, e->a.c);
    front = sfield__lanes_greater(e->det, none);
    back = sfield__lanes_greater(none, e->det);
    turn = sfield__lanes_select(back, sfield__lanes_all(-1), sfield__lanes_all(1));
    sfield__edge_between(&e->a, turn);
    sfield__edge_between(&e->b, turn);
    sfield__edge_between(&e->c, turn);
    return sfield__mask_bits(sfield__mask_or(front, back));
}

/* Finds the samples of a row t inside an edge: narrows low..high. */
static SFIELD__IN_VIEW void sfield__cut_rows(const sfield__edge *e, sfield__lanes t, float half,
                                             sfield__lanes *low, sfield__lanes *high)
{
    const sfield__lanes c = sfield__lanes_add(sfield__lanes_mul(e->c.y, t), e->c.z);
    const sfield__lanes part = sfield__lanes_sub(sfield__lanes_all(1), sfield__lanes_mul(c, e->inverse));
    const sfield__lanes x = sfield__lanes_sub(sfield__lanes_mul(part, sfield__lanes_all(half)),
                                              sfield__lanes_all(0.5f));
    const sfield__lane_mask beyond =
        sfield__mask_and(e->flat, sfield__lanes_greater(sfield__lanes_all(0), c));
    *low = sfield__lanes_select(e->left, sfield__lanes_max(x, *low), *low);
    *low = sfield__lanes_select(beyond, sfield__lanes_all(3e38f), *low);
    *high = sfield__lanes_select(e->right, sfield__lanes_min(x, *high), *high);
}

/* The planes of 1 / distance of triangles, in rows: s, t, 1, and what the sum is divided by. Sides that do
   not emit are drawn a little farther away; otherwise those of a sheet that shines on both sides would hide
   its light by rounding. */
static SFIELD__IN_VIEW void sfield__store_planes(const sfield__cones *e, float *planes)
{
    const sfield__lanes3 sum = sfield__lanes3_add(sfield__lanes3_add(e->a.c, e->b.c), e->c.c);
    const sfield__lane_mask front = sfield__lanes_greater(e->det, sfield__lanes_all(0));
    const sfield__lanes back = sfield__lanes_mul(sfield__lanes_all(-1.00001f), e->det);
    sfield__lanes_store(planes, sum.x);
    sfield__lanes_store(planes + 16, sum.y);
    sfield__lanes_store(planes + 32, sum.z);
    sfield__lanes_store(planes + 48, sfield__lanes_select(front, e->det, back));
}

/* Stores the corners of triangles: x, y, z of the first corner of each, then those of the others. */
static SFIELD__IN_VIEW void sfield__store_trio(const sfield__trio *q, float *to)
{
    sfield__lanes_store(to, q->a.x);
    sfield__lanes_store(to + 16, q->a.y);
    sfield__lanes_store(to + 32, q->a.z);
    sfield__lanes_store(to + 48, q->b.x);
    sfield__lanes_store(to + 64, q->b.y);
    sfield__lanes_store(to + 80, q->b.z);
    sfield__lanes_store(to + 96, q->c.x);
    sfield__lanes_store(to + 112, q->c.y);
    sfield__lanes_store(to + 128, q->c.z);
}

/* Draws the triangles that `bits` names, each within its box on its face, which they are turned to.
   number: of each lane, read where there are depths or a mask. */
static SFIELD__IN_VIEW void sfield__draw_rows(const sfield__build *b, sfield__view *v,
                                              const sfield__trio *q, sfield__lanes face,
                                              const sfield__boxes *box, uint32_t bits,
                                              const uint32_t *number)
{
    const float half = 0.5f * (float)v->width;
    const size_t words = v->width / 64;
    float planes[64], corners[9 * 16];
    int32_t first[16], x0[16], x1[16];
    sfield__lanes y = box->y0;
    sfield__lane_mask rows;
    sfield__cones e;
    uint32_t front, down;
    bits &= sfield__find_cones(q, &e);
    if (!bits) return;
    front = sfield__mask_bits(sfield__lanes_greater(e.det, sfield__lanes_all(0)));
    sfield__ints_store(first, sfield__lanes_truncate(sfield__lanes_add(
        sfield__lanes_mul(face, sfield__lanes_all((float)v->width)), y)));
    if (v->depth) sfield__store_planes(&e, planes);
    if (b->mask_fn) sfield__store_trio(q, corners);
    rows = sfield__mask_of_bits(bits);
    for (down = 0; bits; down++) {
        sfield__lanes t = sfield__lanes_mul(sfield__lanes_add(y, sfield__lanes_all(0.5f)),
                                            sfield__lanes_all(1 / half));
        sfield__lanes low = box->x0, high = box->x1;
        sfield__lane_mask some;
        t = sfield__lanes_sub(t, sfield__lanes_all(1));
        sfield__cut_rows(&e.a, t, half, &low, &high);
        sfield__cut_rows(&e.b, t, half, &low, &high);
        sfield__cut_rows(&e.c, t, half, &low, &high);
        some = sfield__mask_and(rows, sfield__lanes_at_least(high, low));
        low = sfield__lanes_up(sfield__lanes_keep(some, low));
        high = sfield__lanes_whole(sfield__lanes_keep(some, high));
        some = sfield__mask_and(some, sfield__lanes_at_least(high, low));
        sfield__ints_store(x0, sfield__lanes_truncate(low));
        sfield__ints_store(x1, sfield__lanes_truncate(high));
        for (bits = sfield__mask_bits(some); bits; bits &= bits - 1) {
            const uint32_t l = sfield__first_bit(bits);
            const size_t row = (size_t)first[l] + down;
            uint32_t owner = 0;
            v->touched[row] = 1;
            if (v->depth || b->mask_fn)
                owner = (b->original[number[l]] + 1) | (front >> l & 1 ? 0 : 0x80000000u);
            if (b->mask_fn)
                sfield__draw_masked_span(b, v, row, x0[l], x1[l], planes + l, owner, corners + l);
            else if (v->depth) sfield__draw_span(v, row, x0[l], x1[l], planes + l, owner);
            else sfield__set_bits(v->bits + row * words, x0[l], x1[l]);
        }
        y = sfield__lanes_add(y, sfield__lanes_all(1));
        rows = sfield__mask_and(rows, sfield__lanes_at_least(box->y1, y));
        bits = sfield__mask_bits(rows);
    }
}

/* Draws sixteen triangles that lie over several faces, on each face whose pyramid they may touch. */
SFIELD__KERNEL static void sfield__draw_across(const sfield__build *b, sfield__view *v, const float *eye,
                                               const uint32_t *number)
{
    const sfield__trio t = sfield__pick_trio(b->corner, b->corner_room, eye, number);
    const float width = (float)v->width, h = 0.5f * width;
    const sfield__lanes half = sfield__lanes_all(h), middle = sfield__lanes_all(h - 0.5f);
    const sfield__lanes none = sfield__lanes_all(0);
    uint32_t face;
    for (face = 0; face < 6; face++) {
        sfield__trio q;
        sfield__lanes3 x, y, z, minus;
        sfield__lane_mask all, any;
        sfield__boxes box;
        uint32_t out, whole, used;
        q.a = sfield__turn_to_face(face, t.a);
        q.b = sfield__turn_to_face(face, t.b);
        q.c = sfield__turn_to_face(face, t.c);
        x.x = q.a.x, x.y = q.b.x, x.z = q.c.x;
        y.x = q.a.y, y.y = q.b.y, y.z = q.c.y;
        z.x = q.a.z, z.y = q.b.z, z.z = q.c.z;
#define SFIELD__ALL_BEYOND(v)                                                                              \
    sfield__mask_and(sfield__mask_and(sfield__lanes_greater(v.x, z.x), sfield__lanes_greater(v.y, z.y)),   \
                     sfield__lanes_greater(v.z, z.z))
        minus = sfield__lanes3_scale(x, sfield__lanes_all(-1));
        all = sfield__mask_or(SFIELD__ALL_BEYOND(x), SFIELD__ALL_BEYOND(minus));
        minus = sfield__lanes3_scale(y, sfield__lanes_all(-1));
        all = sfield__mask_or(all, sfield__mask_or(SFIELD__ALL_BEYOND(y), SFIELD__ALL_BEYOND(minus)));
#undef SFIELD__ALL_BEYOND
        out = sfield__mask_bits(all);
        all = sfield__lanes_greater(sfield__lanes_min3(z.x, z.y, z.z), none);
        any = sfield__lanes_greater(sfield__lanes_max3(z.x, z.y, z.z), none);
        used = sfield__mask_bits(any) & ~out;
        if (!used) continue;
        whole = sfield__mask_bits(all);
        x.x = sfield__lanes_div(x.x, z.x);
        x.y = sfield__lanes_div(x.y, z.y);
        x.z = sfield__lanes_div(x.z, z.z);
        y.x = sfield__lanes_div(y.x, z.x);
        y.y = sfield__lanes_div(y.y, z.y);
        y.z = sfield__lanes_div(y.z, z.z);
        box.x0 = sfield__lanes_add(sfield__lanes_mul(sfield__lanes_min3(x.x, x.y, x.z), half), middle);
        box.y0 = sfield__lanes_add(sfield__lanes_mul(sfield__lanes_min3(y.x, y.y, y.z), half), middle);
        box.x1 = sfield__lanes_add(sfield__lanes_mul(sfield__lanes_max3(x.x, x.y, x.z), half), middle);
        box.y1 = sfield__lanes_add(sfield__lanes_mul(sfield__lanes_max3(y.x, y.y, y.z), half), middle);
        box = sfield__round_boxes(box, width);
        used &= (whole & sfield__mask_bits(box.used)) | ~whole;
        box.used = sfield__mask_of_bits(used);
        box.x0 = sfield__lanes_keep(all, box.x0);
        box.y0 = sfield__lanes_keep(all, box.y0);
        box.x1 = sfield__lanes_select(all, box.x1, sfield__lanes_all(width - 1));
        box.y1 = sfield__lanes_select(all, box.y1, sfield__lanes_all(width - 1));
        if (used) sfield__draw_rows(b, v, &q, sfield__lanes_all((float)face), &box, used, number);
    }
}

/* See sfield__draw_triangles16. Triangles that lie over several faces wait until there are sixteen; the last
   of them go with some that were drawn before, which changes nothing. Triangles with a corner at the eye, and
   those of three equal corners in the last lanes of the planes, have no cone. */
SFIELD__KERNEL static void sfield__draw_triangles(const sfield__build *b, sfield__view *v, const float *eye)
{
    const float width = (float)v->width;
    const sfield__lanes half = sfield__lanes_all(0.5f * width), one_half = sfield__lanes_all(0.5f);
    uint32_t across[32], number[16], waiting = 0, l;
    size_t i;
    memset(across, 0, sizeof across);
    for (i = 0; i < b->triangles; i += 16) {
        const sfield__trio t = sfield__load_trio(b->corner + i, b->corner_room, eye);
        const sfield__sides on = sfield__sides_of(t.a);
        const sfield__trio q = sfield__turn_to_sides(&t, &on);
        sfield__lanes3 scale, x, y;
        sfield__boxes box;
        uint32_t one = sfield__on_one_face(&t, on.number), used;
        for (used = ~one & 0xffffu; used; used &= used - 1)
            across[waiting++] = (uint32_t)i + sfield__first_bit(used);
        scale.x = sfield__lanes_div(half, q.a.z);
        scale.y = sfield__lanes_div(half, q.b.z);
        scale.z = sfield__lanes_div(half, q.c.z);
#define SFIELD__PLACE(a, scale)                                                                            \
    sfield__lanes_sub(sfield__lanes_add(sfield__lanes_mul(a, scale), half), one_half)
        x.x = SFIELD__PLACE(q.a.x, scale.x);
        x.y = SFIELD__PLACE(q.b.x, scale.y);
        x.z = SFIELD__PLACE(q.c.x, scale.z);
        y.x = SFIELD__PLACE(q.a.y, scale.x);
        y.y = SFIELD__PLACE(q.b.y, scale.y);
        y.z = SFIELD__PLACE(q.c.y, scale.z);
#undef SFIELD__PLACE
        box.x0 = sfield__lanes_min3(x.x, x.y, x.z);
        box.y0 = sfield__lanes_min3(y.x, y.y, y.z);
        box.x1 = sfield__lanes_max3(x.x, x.y, x.z);
        box.y1 = sfield__lanes_max3(y.x, y.y, y.z);
        box = sfield__round_boxes(box, width);
        used = one & sfield__mask_bits(box.used);
        if (used) {
            for (l = 0; l < 16 && (v->depth || b->mask_fn); l++) number[l] = (uint32_t)i + l;
            sfield__draw_rows(b, v, &q, on.number, &box, used, number);
        }
        if (waiting < 16) continue;
        sfield__draw_across(b, v, eye, across);
        waiting -= 16;
        for (l = 0; l < waiting; l++) across[l] = across[16 + l];
    }
    if (waiting) sfield__draw_across(b, v, eye, across);
}

/* ==== src/shadowfield/kernels_inside.h ==== */

/* ---- kernels: where rays meet sixteen triangles ---- */

#define sfield__find_crossings SFIELD__NAME_IN_SET(sfield__find_crossings, SFIELD__SET)

/* See sfield__find_crossings16. Triangles are cones from the eye, as where views are drawn; one that lies on
   one face of the cube about the eye meets rays through that face alone. */
SFIELD__KERNEL static void sfield__find_crossings(const sfield__build *b, const float *eye,
                                                  sfield__inside_ray *ray)
{
    const sfield__lanes none = sfield__lanes_all(0);
    float way[16];
    size_t at;
    for (at = 0; at < b->triangles; at += 16) {
        const sfield__trio t = sfield__load_trio(b->corner + at, b->corner_room, eye);
        const sfield__lanes number = sfield__sides_of(t.a).number;
        const uint32_t one = sfield__on_one_face(&t, number);
        uint32_t on[6], front, seen;
        uint32_t i, bits;
        sfield__lanes3 n = sfield__lanes3_cross(t.a, t.b), o = sfield__lanes3_cross(t.b, t.c), all;
        sfield__lanes3 m = sfield__lanes3_cross(t.c, t.a);
        const sfield__lanes det = sfield__lanes3_dot(n, t.c);
        const sfield__lane_mask back = sfield__lanes_greater(none, det);
        const sfield__lanes turn = sfield__lanes_select(back, sfield__lanes_all(-1), sfield__lanes_all(1));
        front = sfield__mask_bits(sfield__lanes_greater(det, none));
        seen = front | sfield__mask_bits(back);
        if (!seen) continue;
        for (i = 0; i < 6; i++)
            on[i] = seen & (~one | ~sfield__mask_bits(
                                       sfield__lanes_differ(number, sfield__lanes_all((float)i))));
        n = sfield__lanes3_scale(n, turn);
        o = sfield__lanes3_scale(o, turn);
        m = sfield__lanes3_scale(m, turn);
        all = sfield__lanes3_add(sfield__lanes3_add(n, o), m);
        for (i = 0; i < SFIELD__INSIDE_RAYS; i++) {
            const sfield__lanes3 d = sfield__lanes3_all(ray[i].d[0], ray[i].d[1], ray[i].d[2]);
            sfield__lane_mask hit;
            if (!on[ray[i].face]) continue;
            hit = sfield__mask_and(sfield__lanes_greater(sfield__lanes3_dot(n, d), none),
                                   sfield__lanes_greater(sfield__lanes3_dot(o, d), none));
            hit = sfield__mask_and(hit, sfield__lanes_greater(sfield__lanes3_dot(m, d), none));
            bits = on[ray[i].face] & sfield__mask_bits(hit);
            if (!bits) continue;
            sfield__lanes_store(way, sfield__lanes_div(sfield__lanes_abs(det), sfield__lanes3_dot(all, d)));
            for (; bits; bits &= bits - 1) {
                const uint32_t l = sfield__first_bit(bits);
                sfield__add_crossing(&ray[i], way[l], (int)(front >> l & 1));
            }
        }
    }
}

/* ==== src/shadowfield/kernels_products.h ==== */

/* ---- kernels: products of sixteen pairs of vectors ---- */

/* Returns a_i b_j + a_j b_i, or a_i b_i if i is j. */
static SFIELD__IN_LARGE_KERNEL sfield__lanes sfield__pair(const float *a, const float *b, size_t stride,
                                                                 uint32_t i, uint32_t j)
{
    const float *bi = b + i * stride, *aj = a + j * stride;
    const sfield__lanes one = sfield__lanes_mul(sfield__lanes_load(a + i * stride),
                                                sfield__lanes_load(b + j * stride));
    return i == j ? one : sfield__lanes_muladd(sfield__lanes_load(bi), sfield__lanes_load(aj), one);
}

/* Writes to r, a place for each output, the terms that have an index 0. These need no table, since the
   tripling coefficients C_0jj are Y_00 for every j. */
static inline SFIELD__IN_KERNEL void sfield__product_begin(const float *a, const float *b, size_t stride,
                                                           uint32_t coefs, sfield__lanes *r)
{
    const sfield__lanes y00 = sfield__lanes_all(sfield__y00);
    const sfield__lanes a0 = sfield__lanes_mul(sfield__lanes_load(a), y00);
    const sfield__lanes b0 = sfield__lanes_mul(sfield__lanes_load(b), y00);
    sfield__lanes sum = sfield__lanes_mul(sfield__lanes_load(a), sfield__lanes_load(b));
    uint32_t k;
    for (k = 1; k < coefs; k++) {
        const sfield__lanes ak = sfield__lanes_load(a + k * stride), bk = sfield__lanes_load(b + k * stride);
        sum = sfield__lanes_muladd(ak, bk, sum);
        r[k] = sfield__lanes_muladd(b0, ak, sfield__lanes_mul(a0, bk));
    }
    r[0] = sfield__lanes_mul(sum, y00);
}

/* Writes the products r, or with occlude a - r, which is a times a visibility of 1 - b. */
static inline SFIELD__IN_KERNEL void sfield__product_end(const float *a, size_t stride, uint32_t coefs,
                                                         int occlude, const sfield__lanes *r, float *out)
{
    uint32_t k;
    for (k = 0; k < coefs; k++)
        sfield__lanes_store(out + k * stride, !occlude ? r[k] :
                                              sfield__lanes_sub(sfield__lanes_load(a + k * stride), r[k]));
}

/* Pairs a_i b_j + a_j b_i are made once and serve one to three outputs. From 6 bands on they would pass what
   a stack should hold, so that they are made again for every use. */
SFIELD__KERNEL static void sfield__product(const sfield_algebra *t, const float *a, const float *b,
                                           float *out, size_t stride, int occlude)
{
    sfield__lanes p[SFIELD__STAGED + SFIELD__STAGED_COEFS], *r, sum;
    uint32_t i, k, q, staged = t->pair_count <= SFIELD__STAGED;
    r = p + (staged ? SFIELD__STAGED : 0);
    for (i = 1; i < t->coefs && staged; i++)
        for (q = t->row[i]; q < t->row[i + 1]; q++) p[q] = sfield__pair(a, b, stride, i, t->pair[q]);
    sfield__product_begin(a, b, stride, t->coefs, r);
    for (k = 1; k < t->coefs; k++) {
        const sfield__entry *e = t->entry + t->first[k], *end = t->entry + t->first[k + 1];
        sum = r[k];
        if (staged)
            for (; e < end; e++) sum = sfield__lanes_muladd(sfield__lanes_all(e->c), p[e->pair], sum);
        else
            for (; e < end; e++)
                sum = sfield__lanes_muladd(sfield__lanes_all(e->c),
                                           sfield__pair(a, b, stride, t->pair_i[e->pair], t->pair[e->pair]),
                                           sum);
        r[k] = sum;
    }
    sfield__product_end(a, stride, t->coefs, occlude, r, out);
}

/* ==== src/shadowfield/kernels_products4.h ==== */

/* ---- kernels: products of four bands ---- */

#if SFIELD__WIDTH > 4
/* Products of 4 bands, which most fields have, without loops: the branches of short loops cost more than the
   arithmetic. Pairs and terms are those of sfield_algebra's tables, in their order, so that the sums have the
   same bits. A change of the tables' order shows in four_bands_have_the_bits_of_the_loops of the tests; the
   lines are then written from pair_i, pair, first and entry of an algebra of 4 bands. */
static inline SFIELD__IN_KERNEL void sfield__pairs4(const float *a, const float *b, size_t stride,
                                                    sfield__lanes *p)
{
    p[0] = sfield__pair(a, b, stride, 1, 1);           p[1] = sfield__pair(a, b, stride, 2, 1);
    p[2] = sfield__pair(a, b, stride, 2, 2);           p[3] = sfield__pair(a, b, stride, 3, 1);
    p[4] = sfield__pair(a, b, stride, 3, 2);          p[5] = sfield__pair(a, b, stride, 3, 3);
    p[6] = sfield__pair(a, b, stride, 4, 1);          p[7] = sfield__pair(a, b, stride, 4, 2);
    p[8] = sfield__pair(a, b, stride, 4, 3);          p[9] = sfield__pair(a, b, stride, 4, 4);
    p[10] = sfield__pair(a, b, stride, 5, 1);         p[11] = sfield__pair(a, b, stride, 5, 2);
    p[12] = sfield__pair(a, b, stride, 5, 3);         p[13] = sfield__pair(a, b, stride, 5, 4);
    p[14] = sfield__pair(a, b, stride, 5, 5);          p[15] = sfield__pair(a, b, stride, 6, 1);
    p[16] = sfield__pair(a, b, stride, 6, 2);         p[17] = sfield__pair(a, b, stride, 6, 3);
    p[18] = sfield__pair(a, b, stride, 6, 4);         p[19] = sfield__pair(a, b, stride, 6, 5);
    p[20] = sfield__pair(a, b, stride, 6, 6);          p[21] = sfield__pair(a, b, stride, 7, 1);
    p[22] = sfield__pair(a, b, stride, 7, 2);         p[23] = sfield__pair(a, b, stride, 7, 3);
    p[24] = sfield__pair(a, b, stride, 7, 4);         p[25] = sfield__pair(a, b, stride, 7, 5);
    p[26] = sfield__pair(a, b, stride, 7, 6);         p[27] = sfield__pair(a, b, stride, 7, 7);
    p[28] = sfield__pair(a, b, stride, 8, 1);         p[29] = sfield__pair(a, b, stride, 8, 2);
    p[30] = sfield__pair(a, b, stride, 8, 3);         p[31] = sfield__pair(a, b, stride, 8, 5);
    p[32] = sfield__pair(a, b, stride, 8, 6);         p[33] = sfield__pair(a, b, stride, 8, 7);
    p[34] = sfield__pair(a, b, stride, 8, 8);          p[35] = sfield__pair(a, b, stride, 9, 1);
    p[36] = sfield__pair(a, b, stride, 9, 3);         p[37] = sfield__pair(a, b, stride, 9, 4);
    p[38] = sfield__pair(a, b, stride, 9, 5);         p[39] = sfield__pair(a, b, stride, 9, 6);
    p[40] = sfield__pair(a, b, stride, 9, 7);         p[41] = sfield__pair(a, b, stride, 9, 8);
    p[42] = sfield__pair(a, b, stride, 9, 9);          p[43] = sfield__pair(a, b, stride, 10, 1);
    p[44] = sfield__pair(a, b, stride, 10, 2);        p[45] = sfield__pair(a, b, stride, 10, 3);
    p[46] = sfield__pair(a, b, stride, 10, 4);        p[47] = sfield__pair(a, b, stride, 10, 5);
    p[48] = sfield__pair(a, b, stride, 10, 7);        p[49] = sfield__pair(a, b, stride, 10, 9);
    p[50] = sfield__pair(a, b, stride, 11, 1);        p[51] = sfield__pair(a, b, stride, 11, 2);
    p[52] = sfield__pair(a, b, stride, 11, 3);        p[53] = sfield__pair(a, b, stride, 11, 4);
    p[54] = sfield__pair(a, b, stride, 11, 5);        p[55] = sfield__pair(a, b, stride, 11, 6);
    p[56] = sfield__pair(a, b, stride, 11, 7);        p[57] = sfield__pair(a, b, stride, 11, 8);
    p[58] = sfield__pair(a, b, stride, 11, 9);        p[59] = sfield__pair(a, b, stride, 11, 10);
    p[60] = sfield__pair(a, b, stride, 11, 11);         p[61] = sfield__pair(a, b, stride, 12, 1);
    p[62] = sfield__pair(a, b, stride, 12, 2);        p[63] = sfield__pair(a, b, stride, 12, 3);
    p[64] = sfield__pair(a, b, stride, 12, 4);        p[65] = sfield__pair(a, b, stride, 12, 5);
    p[66] = sfield__pair(a, b, stride, 12, 6);        p[67] = sfield__pair(a, b, stride, 12, 7);
    p[68] = sfield__pair(a, b, stride, 12, 8);        p[69] = sfield__pair(a, b, stride, 12, 10);
    p[70] = sfield__pair(a, b, stride, 12, 11);       p[71] = sfield__pair(a, b, stride, 12, 12);
    p[72] = sfield__pair(a, b, stride, 13, 1);        p[73] = sfield__pair(a, b, stride, 13, 2);
    p[74] = sfield__pair(a, b, stride, 13, 3);        p[75] = sfield__pair(a, b, stride, 13, 4);
    p[76] = sfield__pair(a, b, stride, 13, 5);        p[77] = sfield__pair(a, b, stride, 13, 6);
    p[78] = sfield__pair(a, b, stride, 13, 7);        p[79] = sfield__pair(a, b, stride, 13, 8);
    p[80] = sfield__pair(a, b, stride, 13, 9);        p[81] = sfield__pair(a, b, stride, 13, 10);
    p[82] = sfield__pair(a, b, stride, 13, 11);       p[83] = sfield__pair(a, b, stride, 13, 12);
    p[84] = sfield__pair(a, b, stride, 13, 13);         p[85] = sfield__pair(a, b, stride, 14, 1);
    p[86] = sfield__pair(a, b, stride, 14, 2);        p[87] = sfield__pair(a, b, stride, 14, 3);
    p[88] = sfield__pair(a, b, stride, 14, 5);        p[89] = sfield__pair(a, b, stride, 14, 7);
    p[90] = sfield__pair(a, b, stride, 14, 8);        p[91] = sfield__pair(a, b, stride, 14, 9);
    p[92] = sfield__pair(a, b, stride, 14, 11);       p[93] = sfield__pair(a, b, stride, 14, 12);
    p[94] = sfield__pair(a, b, stride, 14, 13);       p[95] = sfield__pair(a, b, stride, 15, 1);
    p[96] = sfield__pair(a, b, stride, 15, 3);        p[97] = sfield__pair(a, b, stride, 15, 4);
    p[98] = sfield__pair(a, b, stride, 15, 5);        p[99] = sfield__pair(a, b, stride, 15, 6);
    p[100] = sfield__pair(a, b, stride, 15, 7);       p[101] = sfield__pair(a, b, stride, 15, 8);
    p[102] = sfield__pair(a, b, stride, 15, 10);      p[103] = sfield__pair(a, b, stride, 15, 11);
    p[104] = sfield__pair(a, b, stride, 15, 13);      p[105] = sfield__pair(a, b, stride, 15, 14);
    p[106] = sfield__pair(a, b, stride, 15, 15);
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__term(const sfield__entry *c, sfield__lanes sum,
                                                           const sfield__lanes *pair)
{
    return sfield__lanes_muladd(sfield__lanes_all(c->c), *pair, sum);
}

static SFIELD__IN_LARGE_KERNEL sfield__lanes sfield__four_terms(const sfield__entry *c, sfield__lanes sum,
                                                                       const sfield__lanes *p,
                                                                       const sfield__lanes *q,
                                                                       const sfield__lanes *s,
                                                                       const sfield__lanes *t)
{
    sum = sfield__term(c, sum, p);
    sum = sfield__term(c + 1, sum, q);
    sum = sfield__term(c + 2, sum, s);
    return sfield__term(c + 3, sum, t);
}

static inline SFIELD__IN_KERNEL void sfield__terms4(const sfield__entry *c, const sfield__lanes *p,
                                                    sfield__lanes *r)
{
    r[1] = sfield__four_terms(c + 0, r[1], &p[8], &p[11], &p[15], &p[28]);
    r[1] = sfield__four_terms(c + 4, r[1], &p[41], &p[48], &p[55], &p[57]);
    r[1] = sfield__four_terms(c + 8, r[1], &p[65], &p[75], &p[88], &p[97]);
    r[2] = sfield__four_terms(c + 12, r[2], &p[10], &p[16], &p[23], &p[46]);
    r[2] = sfield__four_terms(c + 16, r[2], &p[54], &p[66], &p[78], &p[90]);
    r[3] = sfield__four_terms(c + 20, r[3], &p[6], &p[17], &p[22], &p[30]);
    r[3] = sfield__four_terms(c + 24, r[3], &p[37], &p[47], &p[53], &p[67]);
    r[3] = sfield__four_terms(c + 28, r[3], &p[77], &p[79], &p[89], &p[101]);
    r[4] = sfield__four_terms(c + 32, r[4], &p[3], &p[18], &p[25], &p[36]);
    r[4] = sfield__four_terms(c + 36, r[4], &p[44], &p[52], &p[69], &p[72]);
    r[4] = sfield__four_terms(c + 40, r[4], &p[80], &p[82], &p[95], &p[103]);
    r[5] = sfield__four_terms(c + 44, r[5], &p[1], &p[19], &p[24], &p[31]);
    r[5] = sfield__four_terms(c + 48, r[5], &p[45], &p[51], &p[61], &p[70]);
    r[5] = sfield__four_terms(c + 52, r[5], &p[81], &p[85], &p[91], &p[92]);
    r[5] = sfield__term(c + 56, r[5], &p[102]);
    r[6] = sfield__four_terms(c + 57, r[6], &p[0], &p[2], &p[5], &p[9]);
    r[6] = sfield__four_terms(c + 61, r[6], &p[14], &p[20], &p[27], &p[34]);
    r[6] = sfield__four_terms(c + 65, r[6], &p[42], &p[50], &p[60], &p[62]);
    r[6] = sfield__four_terms(c + 69, r[6], &p[71], &p[74], &p[84], &p[106]);
    r[7] = sfield__four_terms(c + 73, r[7], &p[4], &p[13], &p[26], &p[33]);
    r[7] = sfield__four_terms(c + 77, r[7], &p[43], &p[49], &p[59], &p[63]);
    r[7] = sfield__four_terms(c + 81, r[7], &p[73], &p[83], &p[87], &p[94]);
    r[7] = sfield__term(c + 85, r[7], &p[105]);
    r[8] = sfield__four_terms(c + 86, r[8], &p[0], &p[5], &p[14], &p[27]);
    r[8] = sfield__four_terms(c + 90, r[8], &p[32], &p[35], &p[50], &p[58]);
    r[8] = sfield__four_terms(c + 94, r[8], &p[60], &p[74], &p[84], &p[86]);
    r[8] = sfield__term(c + 98, r[8], &p[93]);
    r[8] = sfield__term(c + 99, r[8], &p[96]);
    r[8] = sfield__term(c + 100, r[8], &p[104]);
    r[9] = sfield__four_terms(c + 101, r[9], &p[8], &p[28], &p[39], &p[48]);
    r[9] = sfield__term(c + 105, r[9], &p[57]);
    r[9] = sfield__term(c + 106, r[9], &p[75]);
    r[9] = sfield__term(c + 107, r[9], &p[88]);
    r[10] = sfield__four_terms(c + 108, r[10], &p[7], &p[12], &p[21], &p[40]);
    r[10] = sfield__four_terms(c + 112, r[10], &p[56], &p[64], &p[76], &p[98]);
    r[11] = sfield__four_terms(c + 116, r[11], &p[8], &p[11], &p[15], &p[28]);
    r[11] = sfield__four_terms(c + 120, r[11], &p[41], &p[48], &p[55], &p[57]);
    r[11] = sfield__four_terms(c + 124, r[11], &p[65], &p[75], &p[88], &p[97]);
    r[12] = sfield__four_terms(c + 128, r[12], &p[10], &p[16], &p[23], &p[46]);
    r[12] = sfield__four_terms(c + 132, r[12], &p[54], &p[66], &p[78], &p[90]);
    r[13] = sfield__four_terms(c + 136, r[13], &p[6], &p[17], &p[22], &p[30]);
    r[13] = sfield__four_terms(c + 140, r[13], &p[37], &p[47], &p[53], &p[67]);
    r[13] = sfield__four_terms(c + 144, r[13], &p[77], &p[79], &p[89], &p[101]);
    r[14] = sfield__four_terms(c + 148, r[14], &p[10], &p[23], &p[29], &p[38]);
    r[14] = sfield__four_terms(c + 152, r[14], &p[54], &p[68], &p[78], &p[100]);
    r[15] = sfield__four_terms(c + 156, r[15], &p[6], &p[30], &p[47], &p[53]);
    r[15] = sfield__term(c + 160, r[15], &p[79]);
    r[15] = sfield__term(c + 161, r[15], &p[89]);
    r[15] = sfield__term(c + 162, r[15], &p[99]);
}

SFIELD__KERNEL static void sfield__product4(const sfield_algebra *t, const float *a, const float *b,
                                            float *out, size_t stride, int occlude)
{
    sfield__lanes p[107], r[16];
    sfield__product_begin(a, b, stride, 16, r);
    sfield__pairs4(a, b, stride, p);
    sfield__terms4(t->entry, p, r);
    sfield__product_end(a, stride, 16, occlude, r, out);
}
#endif

/* ==== src/shadowfield/kernels_rotations.h ==== */

/* ---- kernels: rotations of sixteen vectors ---- */

SFIELD__KERNEL static void sfield__rotate(const sfield_rotation *rotation, const float *in, float *out,
                                          size_t stride, int inverse)
{
    const float *block = rotation->block;
    sfield__lanes r[2 * SFIELD_MAX_BANDS];
    uint32_t l, x, y;
    uint32_t n, across, down;
    for (l = 0; l < rotation->bands; l++) {
        n = 2 * l + 1;
        across = inverse ? n : 1;
        down = inverse ? 1 : n;
        for (y = 0; y < n; y++) {
            const float *from = in + (size_t)l * l * stride, *m = block + y * down;
            sfield__lanes sum = sfield__lanes_mul(sfield__lanes_all(m[0]), sfield__lanes_load(from));
            for (x = 1; x < n; x++) {
                const sfield__lanes one = sfield__lanes_load(from + x * stride);
                sum = sfield__lanes_muladd(sfield__lanes_all(m[x * across]), one, sum);
            }
            r[y] = sum;
        }
        for (y = 0; y < n; y++) sfield__lanes_store(out + ((size_t)l * l + y) * stride, r[y]);
        block += n * n;
    }
}

/* Four bands without loops over a row, in bands of 3, 5 and 7 that registers hold. m: a row; s: stride. */
typedef struct sfield__held { sfield__lanes x0, x1, x2, x3, x4, x5, x6; } sfield__held;

static inline SFIELD__IN_KERNEL sfield__lanes sfield__row3(const float *m, uint32_t s, const sfield__held *h)
{
    sfield__lanes sum = sfield__lanes_mul(sfield__lanes_all(m[0]), h->x0);
    sum = sfield__lanes_muladd(sfield__lanes_all(m[s]), h->x1, sum);
    return sfield__lanes_muladd(sfield__lanes_all(m[2 * s]), h->x2, sum);
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__row5(const float *m, uint32_t s, const sfield__held *h)
{
    sfield__lanes sum = sfield__lanes_muladd(sfield__lanes_all(m[3 * s]), h->x3, sfield__row3(m, s, h));
    return sfield__lanes_muladd(sfield__lanes_all(m[4 * s]), h->x4, sum);
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__row7(const float *m, uint32_t s, const sfield__held *h)
{
    sfield__lanes sum = sfield__lanes_muladd(sfield__lanes_all(m[5 * s]), h->x5, sfield__row5(m, s, h));
    return sfield__lanes_muladd(sfield__lanes_all(m[6 * s]), h->x6, sum);
}

SFIELD__KERNEL static void sfield__rotate4(const sfield_rotation *rotation, const float *in, float *out,
                                           size_t stride, int inverse)
{
    const float *m = rotation->block;
    sfield__held h;
    uint32_t y;
    sfield__lanes_store(out, sfield__lanes_mul(sfield__lanes_all(m[0]), sfield__lanes_load(in)));
    h.x0 = sfield__lanes_load(in + stride);
    h.x1 = sfield__lanes_load(in + 2 * stride);
    h.x2 = sfield__lanes_load(in + 3 * stride);
    for (y = 0, m += 1; y < 3; y++)
        sfield__lanes_store(out + (1 + y) * stride,
                            sfield__row3(m + y * (inverse ? 1 : 3), inverse ? 3 : 1, &h));
    h.x0 = sfield__lanes_load(in + 4 * stride);
    h.x1 = sfield__lanes_load(in + 5 * stride);
    h.x2 = sfield__lanes_load(in + 6 * stride);
    h.x3 = sfield__lanes_load(in + 7 * stride);
    h.x4 = sfield__lanes_load(in + 8 * stride);
    for (y = 0, m += 9; y < 5; y++)
        sfield__lanes_store(out + (4 + y) * stride,
                            sfield__row5(m + y * (inverse ? 1 : 5), inverse ? 5 : 1, &h));
    h.x0 = sfield__lanes_load(in + 9 * stride);
    h.x1 = sfield__lanes_load(in + 10 * stride);
    h.x2 = sfield__lanes_load(in + 11 * stride);
    h.x3 = sfield__lanes_load(in + 12 * stride);
    h.x4 = sfield__lanes_load(in + 13 * stride);
    h.x5 = sfield__lanes_load(in + 14 * stride);
    h.x6 = sfield__lanes_load(in + 15 * stride);
    for (y = 0, m += 25; y < 7; y++)
        sfield__lanes_store(out + (9 + y) * stride,
                            sfield__row7(m + y * (inverse ? 1 : 7), inverse ? 7 : 1, &h));
}

/* ==== src/shadowfield/kernels_samples.h ==== */

/* ---- kernels: between eight samples ---- */

/* See sfield__widen_samples. What is written after a sample's last value gives way to the next sample. */
SFIELD__KERNEL static void sfield__widen(const sfield_field *f, const uint8_t *first, uint32_t n, float *out)
{
    const size_t stride = f->h.stride, row = f->h.position_side * stride,
                 shell = 6 * f->h.position_side * row;
    uint32_t i, k;
    for (i = 0; i < 8; i++, out += n) {
        const uint8_t *q = first + (i & 1) * stride + (i >> 1 & 1) * row + (i >> 2) * shell;
        for (k = 0; k < n; k += 16) sfield__lanes_store(out + k, sfield__lanes_of_bytes(q + k));
    }
}

/* See sfield__rows_to_planes. */
SFIELD__KERNEL static void sfield__transpose(const float *rows, size_t stride, uint32_t n, float *planes)
{
    uint32_t k, l;
    for (k = 0; k < n; k += 8)
        for (l = 0; l < 16; l += 8)
            sfield__transpose8(rows + l * stride + k, stride, planes + 16 * k + l, 16);
}

/* The weights that sixteen points between the same eight samples give to each of these. */
typedef struct sfield__corner_weights {
    sfield__lanes x0, x1, x2, x3;   /* of the corners of a shell */
    sfield__lanes w0, w1;           /* of the shells */
} sfield__corner_weights;

static inline SFIELD__IN_KERNEL sfield__corner_weights sfield__corner_weights_of(const sfield__place *at,
                                                                                 const float *factor)
{
    const sfield__lanes one = sfield__lanes_all(1), own = sfield__lanes_load(factor);
    const sfield__lanes fx = sfield__lanes_load(at->fx), fy = sfield__lanes_load(at->fy);
    const sfield__lanes gx = sfield__lanes_sub(one, fx), gy = sfield__lanes_sub(one, fy);
    sfield__corner_weights w;
    w.x0 = sfield__lanes_mul(gx, gy);
    w.x1 = sfield__lanes_mul(fx, gy);
    w.x2 = sfield__lanes_mul(gx, fy);
    w.x3 = sfield__lanes_mul(fx, fy);
    w.w0 = sfield__lanes_mul(sfield__lanes_load(at->w0), own);
    w.w1 = sfield__lanes_mul(sfield__lanes_load(at->w1), own);
    return w;
}

/* Interpolates n coefficients, from one on, of one point, sixteen of them at a time. base and group: the
   sample and the scales of the inner shell's first corner. The weights are the same in all lanes. */
static inline SFIELD__IN_KERNEL void sfield__mix_row(const sfield_field *f, size_t base, size_t group,
                                                     uint32_t from, uint32_t n,
                                                     const sfield__corner_weights *w, float *out)
{
    const size_t stride = f->h.stride, row = f->h.position_side * stride,
                 shell = 6 * f->h.position_side * row;
    const uint8_t *q = f->sample + base * stride + from;
    const float *s0 = f->scale + group * stride + from, *b0 = f->bias + group * stride + from;
    uint32_t k;
    for (k = 0; k < n; k += 16, q += 16) {
        sfield__lanes a = sfield__lanes_mul(sfield__lanes_of_bytes(q), w->x0);
        sfield__lanes c = sfield__lanes_mul(sfield__lanes_of_bytes(q + shell), w->x0);
        a = sfield__lanes_muladd(sfield__lanes_of_bytes(q + stride), w->x1, a);
        c = sfield__lanes_muladd(sfield__lanes_of_bytes(q + shell + stride), w->x1, c);
        a = sfield__lanes_muladd(sfield__lanes_of_bytes(q + row), w->x2, a);
        c = sfield__lanes_muladd(sfield__lanes_of_bytes(q + shell + row), w->x2, c);
        a = sfield__lanes_muladd(sfield__lanes_of_bytes(q + row + stride), w->x3, a);
        c = sfield__lanes_muladd(sfield__lanes_of_bytes(q + shell + row + stride), w->x3, c);
        a = sfield__lanes_muladd(a, sfield__lanes_load(s0 + k), sfield__lanes_load(b0 + k));
        c = sfield__lanes_muladd(c, sfield__lanes_load(s0 + stride + k), sfield__lanes_load(b0 + stride + k));
        sfield__lanes_store(out + k, sfield__lanes_muladd(c, w->w1, sfield__lanes_mul(a, w->w0)));
    }
}

/* See sfield__mix_samples. */
SFIELD__KERNEL static void sfield__mix(const sfield_field *f, const sfield__between *at, uint32_t n,
                                       float *out)
{
    sfield__corner_weights w;
    w.x0 = sfield__lanes_all(at->corner[0]);
    w.x1 = sfield__lanes_all(at->corner[1]);
    w.x2 = sfield__lanes_all(at->corner[2]);
    w.x3 = sfield__lanes_all(at->corner[3]);
    w.w0 = sfield__lanes_all(at->inner);
    w.w1 = sfield__lanes_all(at->outer);
    sfield__mix_row(f, at->base, at->group, 0, n, &w, out);
}

/* Interpolates one coefficient between the four samples of a shell: q[0], q[n], q[2 n] and q[3 n]. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__between_four(const sfield__corner_weights *w,
                                                                   const float *q,
                                                                   uint32_t n, float scale, float bias)
{
    sfield__lanes sum = sfield__lanes_mul(sfield__lanes_all(q[0]), w->x0);
    sum = sfield__lanes_muladd(sfield__lanes_all(q[n]), w->x1, sum);
    sum = sfield__lanes_muladd(sfield__lanes_all(q[2 * n]), w->x2, sum);
    sum = sfield__lanes_muladd(sfield__lanes_all(q[3 * n]), w->x3, sum);
    return sfield__lanes_muladd(sum, sfield__lanes_all(scale), sfield__lanes_all(bias));
}

/* Copies of the pointers to scale and bias of both shells, or compilers load them again after every store. */
typedef struct sfield__shells { const float *q, *s0, *b0, *s1, *b1; uint32_t n; } sfield__shells;

static inline SFIELD__IN_KERNEL sfield__shells sfield__shells_of(const sfield__eight *c)
{
    sfield__shells s;
    s.q = c->q;
    s.s0 = c->s0;
    s.b0 = c->b0;
    s.s1 = c->s1;
    s.b1 = c->b1;
    s.n = c->n;
    return s;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__between_eight(const sfield__corner_weights *w,
                                                                    const sfield__shells *s, uint32_t k)
{
    const sfield__lanes inner = sfield__between_four(w, s->q + k, s->n, s->s0[k], s->b0[k]);
    const sfield__lanes outer = sfield__between_four(w, s->q + 4 * s->n + k, s->n, s->s1[k], s->b1[k]);
    return sfield__lanes_muladd(outer, w->w1, sfield__lanes_mul(inner, w->w0));
}

/* Interpolates between eight samples, for the lanes by their factors. out holds n planes; unless more is 0
   the coefficients are added to what the planes hold. */
SFIELD__KERNEL static void sfield__eight_to_planes(const sfield__eight *c, const sfield__place *at,
                                                   const float *factor, int more, float *out)
{
    const sfield__corner_weights w = sfield__corner_weights_of(at, factor);
    const sfield__shells s = sfield__shells_of(c);
    const sfield__lanes one = sfield__lanes_all(1);
    uint32_t k;
    for (k = 0; k < s.n; k++, out += 16) {
        sfield__lanes a = sfield__between_eight(&w, &s, k);
        if (more) a = sfield__lanes_muladd(sfield__lanes_load(out), one, a);
        sfield__lanes_store(out, a);
    }
}

/* Adds up eight sums of every lane: the second four to the first four, then halves again. */
static inline SFIELD__IN_KERNEL void sfield__add_parts(sfield__lanes *part, float *sum)
{
    const sfield__lanes one = sfield__lanes_all(1);
    uint32_t k, i;
    for (k = 4; k > 0; k /= 2)
        for (i = 0; i < k; i++) part[i] = sfield__lanes_muladd(part[i], one, part[i + k]);
    sfield__lanes_store(sum, sfield__lanes_muladd(part[0], one, sfield__lanes_load(sum)));
}

/* Adds every lane's dot product with t, n planes, to sum. */
SFIELD__KERNEL static void sfield__eight_times(const sfield__eight *c, const sfield__place *at,
                                               const float *factor, const float *t, float *sum)
{
    const sfield__corner_weights w = sfield__corner_weights_of(at, factor);
    const sfield__shells s = sfield__shells_of(c);
    sfield__lanes part[8];
    uint32_t k;
    for (k = 0; k < s.n; k++) {
        const sfield__lanes a = sfield__between_eight(&w, &s, k), x = sfield__lanes_load(t + 16 * k);
        part[k & 7] = k < 8 ? sfield__lanes_mul(a, x) : sfield__lanes_muladd(a, x, part[k & 7]);
    }
    sfield__add_parts(part, sum);
}

/* Does what sfield__eight_times does, with the same bits, for coefficients that are in planes already. */
SFIELD__KERNEL static void sfield__planes_times(const float *planes, const float *t, uint32_t n, float *sum)
{
    sfield__lanes part[8];
    uint32_t k;
    for (k = 0; k < n; k++) {
        const sfield__lanes a = sfield__lanes_load(planes + 16 * k), x = sfield__lanes_load(t + 16 * k);
        part[k & 7] = k < 8 ? sfield__lanes_mul(a, x) : sfield__lanes_muladd(a, x, part[k & 7]);
    }
    sfield__add_parts(part, sum);
}

/* See sfield__dot_single. */
SFIELD__KERNEL static void sfield__singles_times(const sfield_field *f, const sfield__place *at,
                                                 uint32_t frame, const float *factor, uint32_t from,
                                                 uint32_t n, const float *t, float *room, float *sum)
{
    const sfield__corner_weights all = sfield__corner_weights_of(at, factor);
    const size_t sample = frame * 6 * (size_t)f->h.position_side * f->h.position_side * f->h.shells;
    const size_t group = (size_t)frame * f->h.shells;
    float *planes = room + 16 * n, each[6][16];
    uint32_t l;
    sfield__lanes_store(each[0], all.x0);
    sfield__lanes_store(each[1], all.x1);
    sfield__lanes_store(each[2], all.x2);
    sfield__lanes_store(each[3], all.x3);
    sfield__lanes_store(each[4], all.w0);
    sfield__lanes_store(each[5], all.w1);
    for (l = 0; l < 16; l++) {
        sfield__corner_weights w;
        w.x0 = sfield__lanes_all(each[0][l]);
        w.x1 = sfield__lanes_all(each[1][l]);
        w.x2 = sfield__lanes_all(each[2][l]);
        w.x3 = sfield__lanes_all(each[3][l]);
        w.w0 = sfield__lanes_all(each[4][l]);
        w.w1 = sfield__lanes_all(each[5][l]);
        sfield__mix_row(f, sample + (size_t)at->base[l], group + (size_t)at->shell[l], from, n, &w,
                        room + l * n);
    }
    sfield__transpose(room, n, n, planes);
    sfield__planes_times(planes, t, n, sum);
}

/* ==== src/shadowfield/kernels_tiles.h ==== */

/* ---- kernels: where sixteen points lie, and which occluders they see ---- */

#if SFIELD__WIDTH <= 8          /* with AVX-512 those of AVX2 serve */
/* Returns 4/pi atan u for |u| <= 1: equal angles between the nodes of the position grid. The fit is our own,
   within 6e-6, and exact at the ends. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__warp_angle(sfield__lanes u)
{
    const sfield__lanes v = sfield__lanes_mul(u, u), one = sfield__lanes_all(1);
    sfield__lanes s = sfield__lanes_mul(v, sfield__lanes_all(0.0127531015f));
    s = sfield__lanes_mul(v, sfield__lanes_add(sfield__lanes_all(-0.0487783181f), s));
    s = sfield__lanes_mul(v, sfield__lanes_add(sfield__lanes_all(0.0946681494f), s));
    s = sfield__lanes_mul(v, sfield__lanes_add(sfield__lanes_all(-0.150161507f), s));
    s = sfield__lanes_add(sfield__lanes_all(0.273219633f), s);
    return sfield__lanes_add(u, sfield__lanes_mul(sfield__lanes_mul(u, sfield__lanes_sub(one, v)), s));
}

/* Writes how far points lie between the nodes of one axis of a face, and returns the nodes before them. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__node_before(sfield__lanes u, uint32_t side,
                                                                  float *fraction)
{
    const sfield__lanes half = sfield__lanes_all(0.5f * (float)(side - 1)), one = sfield__lanes_all(1);
    const sfield__lanes s = sfield__lanes_mul(sfield__lanes_add(sfield__warp_angle(u), one), half);
    const sfield__lanes most = sfield__lanes_min(s, sfield__lanes_all((float)side - 1.5f));
    const sfield__lanes node = sfield__lanes_of_ints(sfield__lanes_truncate(most));
    sfield__lanes_store(fraction, sfield__lanes_sub(s, node));
    return node;
}

/* Returns what sfield__measure_of says of squared distances of at least 1e-12. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_measure(const sfield_field *f, sfield__lanes d2)
{
    const sfield__lanes one = sfield__lanes_all(1), r = sfield__lanes_div(one, d2);
    const sfield__lanes u = sfield__lanes_min(r, one);
    sfield__lanes w;
    if (f->h.spacing == SFIELD_SPACING_UNIFORM) return sfield__lanes_negate(sfield__lanes_sqrt(d2));
    if (f->h.kind == SFIELD__KIND_SOURCE) return r;
    w = sfield__lanes_div(u, sfield__lanes_add(one, sfield__lanes_sqrt(sfield__lanes_sub(one, u))));
    return sfield__lanes_select(sfield__lanes_greater(one, d2), r, w);
}

/* Computes the weights of both shells; shell: of the inner one. */
static inline SFIELD__IN_KERNEL void sfield__weigh_shells(const sfield_field *f, sfield__lanes d2,
                                                          sfield__lane_ints shell, sfield__place *out)
{
    const sfield__lanes one = sfield__lanes_all(1), q = sfield__lanes_max(d2, sfield__lanes_all(1e-12f));
    const sfield__lanes m0 = sfield__lanes_gather(f->measure, shell);
    const sfield__lanes m1 = sfield__lanes_gather(f->measure + 1, shell);
    const sfield__lanes tail = sfield__lanes_div(sfield__lanes_all(f->radius2[f->h.shells - 1]), q);
    sfield__lanes w = sfield__lanes_sub(sfield__lanes_measure(f, q), m1);
    w = sfield__lanes_div(w, sfield__lanes_sub(m0, m1));
    w = sfield__lanes_min(sfield__lanes_max(w, sfield__lanes_all(0)), one);
    sfield__lanes_store(out->w0, w);
    sfield__lanes_store(out->w1, sfield__lanes_mul(sfield__lanes_sub(one, w), sfield__lanes_min(tail, one)));
}

/* See sfield__locate16. Numbers of samples are floats until they are stored: 64 shells of 6 x 64^2 samples
   are less than 2^24. */
SFIELD__KERNEL static void sfield__locate(const sfield_field *f, const float *p, sfield__place *out)
{
    const sfield__lanes zero = sfield__lanes_all(0), one = sfield__lanes_all(1);
    const sfield__lanes x = sfield__lanes_load(p), y = sfield__lanes_load(p + 16);
    const sfield__lanes z = sfield__lanes_load(p + 32);
    const sfield__lanes ax = sfield__lanes_abs(x), ay = sfield__lanes_abs(y), az = sfield__lanes_abs(z);
    const sfield__lanes m = sfield__lanes_max(sfield__lanes_max(ax, ay), az);
    const sfield__lane_mask is_x = sfield__lanes_at_least(ax, m), is_y = sfield__lanes_at_least(ay, m);
    const sfield__lanes major = sfield__lanes_select(is_x, x, sfield__lanes_select(is_y, y, z));
    const sfield__lane_mask up = sfield__lanes_greater(major, zero);
    const sfield__lanes turn = sfield__lanes_select(up, one, sfield__lanes_all(-1));
    const sfield__lanes inverse = sfield__lanes_div(one, sfield__lanes_max(m, sfield__lanes_all(1e-20f)));
    const sfield__lanes side = sfield__lanes_all((float)f->h.position_side);
    const sfield__lanes z_turned = sfield__lanes_mul(z, turn);
    sfield__lanes d2 = sfield__lanes_add(sfield__lanes_mul(x, x), sfield__lanes_mul(y, y));
    sfield__lanes s = sfield__lanes_select(is_y, x, sfield__lanes_mul(x, turn)), t = sfield__lanes_negate(y);
    sfield__lanes shell = sfield__lanes_all(-1), face;
    uint32_t k;
    s = sfield__lanes_select(is_x, sfield__lanes_negate(z_turned), s);
    t = sfield__lanes_select(is_x, t, sfield__lanes_select(is_y, z_turned, t));
    face = sfield__lanes_select(is_y, sfield__lanes_all(2), sfield__lanes_all(4));
    face = sfield__lanes_select(is_x, zero, face);
    face = sfield__lanes_add(face, sfield__lanes_select(up, zero, one));
    d2 = sfield__lanes_add(d2, sfield__lanes_mul(z, z));
    /* If all points lie beyond the last shell but one, no shell has to be compared. */
    k = sfield__mask_bits(sfield__lanes_at_least(d2, sfield__lanes_all(f->radius2[f->h.shells - 2])));
    if (k == 0xffff) shell = sfield__lanes_all((float)f->h.shells);
    for (k = k == 0xffff ? f->h.shells : 0; k < f->h.shells; k++) {
        const sfield__lane_mask outside = sfield__lanes_at_least(d2, sfield__lanes_all(f->radius2[k]));
        if (!sfield__mask_any(outside)) break;
        shell = sfield__lanes_add(shell, sfield__lanes_keep(outside, one));
    }
    shell = sfield__lanes_min(sfield__lanes_max(shell, zero), sfield__lanes_all((float)(f->h.shells - 2)));
    s = sfield__node_before(sfield__lanes_mul(s, inverse), f->h.position_side, out->fx);
    t = sfield__node_before(sfield__lanes_mul(t, inverse), f->h.position_side, out->fy);
    face = sfield__lanes_add(sfield__lanes_mul(shell, sfield__lanes_all(6)), face);
    face = sfield__lanes_add(sfield__lanes_mul(face, side), t);
    face = sfield__lanes_add(sfield__lanes_mul(face, side), s);
    sfield__ints_store(out->base, sfield__lanes_truncate(face));
    sfield__ints_store(out->shell, sfield__lanes_truncate(shell));
    sfield__weigh_shells(f, d2, sfield__lanes_truncate(shell), out);
}

/* Returns the bits of lanes whose base is the wanted one. */
SFIELD__KERNEL static uint32_t sfield__same_eight(const int32_t *base, int32_t wanted)
{
    return sfield__mask_bits(sfield__ints_equal(sfield__ints_load(base), sfield__ints_all(wanted)));
}

/* Copies planes, with zeros where a mask has no bit. */
SFIELD__KERNEL static void sfield__select(const float *in, uint32_t n, uint32_t mask, float *out)
{
    const sfield__lane_mask lanes = sfield__mask_of_bits(mask);
    const float *end = in + n;
    for (; in < end; in += 16, out += 16)
        sfield__lanes_store(out, sfield__lanes_keep(lanes, sfield__lanes_load(in)));
}

/* Computes where points are in a field of an entity: planes, about its center c, in r. m: 3 x 3; f: 1 / r. */
SFIELD__KERNEL static void sfield__to_local(const float *m, const float *c, float f, const float *p,
                                            float *local)
{
    const sfield__lanes by = sfield__lanes_all(f);
    sfield__lanes x = sfield__lanes_sub(sfield__lanes_load(p), sfield__lanes_all(c[0]));
    sfield__lanes y = sfield__lanes_sub(sfield__lanes_load(p + 16), sfield__lanes_all(c[1]));
    sfield__lanes z = sfield__lanes_sub(sfield__lanes_load(p + 32), sfield__lanes_all(c[2]));
    uint32_t k;
    x = sfield__lanes_mul(x, by);
    y = sfield__lanes_mul(y, by);
    z = sfield__lanes_mul(z, by);
    for (k = 0; k < 3; k++, m += 3) {
        sfield__lanes a = sfield__lanes_mul(sfield__lanes_all(m[0]), x);
        a = sfield__lanes_add(a, sfield__lanes_mul(sfield__lanes_all(m[1]), y));
        a = sfield__lanes_add(a, sfield__lanes_mul(sfield__lanes_all(m[2]), z));
        sfield__lanes_store(local + 16 * k, a);
    }
}

/* Returns the bits of lanes with a < b. */
SFIELD__KERNEL static uint32_t sfield__nearer(const float *a, const float *b)
{
    return sfield__mask_bits(sfield__lanes_greater(sfield__lanes_load(b), sfield__lanes_load(a)));
}

/* Computes the squared distances of the lanes to c. The bits returned: nearer than reach, and, from 16 on, c
   higher above the horizon than low. */
SFIELD__KERNEL static uint32_t sfield__look_at(const float *p, const float *n, const float *c, float reach2,
                                               float low, float *d2)
{
    const sfield__lanes x = sfield__lanes_sub(sfield__lanes_all(c[0]), sfield__lanes_load(p));
    const sfield__lanes y = sfield__lanes_sub(sfield__lanes_all(c[1]), sfield__lanes_load(p + 16));
    const sfield__lanes z = sfield__lanes_sub(sfield__lanes_all(c[2]), sfield__lanes_load(p + 32));
    sfield__lanes d = sfield__lanes_add(sfield__lanes_mul(x, x), sfield__lanes_mul(y, y));
    sfield__lanes h = sfield__lanes_mul(x, sfield__lanes_load(n));
    h = sfield__lanes_add(h, sfield__lanes_mul(y, sfield__lanes_load(n + 16)));
    h = sfield__lanes_add(h, sfield__lanes_mul(z, sfield__lanes_load(n + 32)));
    d = sfield__lanes_add(d, sfield__lanes_mul(z, z));
    sfield__lanes_store(d2, d);
    return sfield__mask_bits(sfield__lanes_greater(sfield__lanes_all(reach2), d)) |
           sfield__mask_bits(sfield__lanes_greater(h, sfield__lanes_all(low))) << 16;
}

/* Computes what is left of an occluder: 1 up to 3/4 of its reach, 0 for lanes that do not count. */
SFIELD__KERNEL static void sfield__fade(const float *d2, float inverse_reach, uint32_t lanes, float *factor)
{
    const sfield__lanes one = sfield__lanes_all(1);
    sfield__lanes d = sfield__lanes_sqrt(sfield__lanes_load(d2));
    d = sfield__lanes_mul(d, sfield__lanes_all(inverse_reach));
    d = sfield__lanes_min(sfield__lanes_mul(sfield__lanes_all(4), sfield__lanes_sub(one, d)), one);
    sfield__lanes_store(factor, sfield__lanes_keep(sfield__mask_of_bits(lanes), d));
}
#endif

/* Computes n planes that a cache has kept, in 16 bits, with a scale for each lane. */
SFIELD__KERNEL static void sfield__recall(const int16_t *value, const float *scale, uint32_t n, float *t)
{
    const sfield__lanes by = sfield__lanes_load(scale);
    const int16_t *end = value + 16 * (size_t)n;
    for (; value < end; value += 16, t += 16)
        sfield__lanes_store(t, sfield__lanes_mul(sfield__lanes_of_shorts(value), by));
}

/* ==== src/shadowfield/kernels_wavelets.h ==== */

/* ---- kernels: wavelets of sixteen points ---- */

static inline SFIELD__IN_KERNEL sfield__lanes sfield__at_least_0(sfield__lanes a)
{
    return sfield__lanes_max(a, sfield__lanes_all(0));
}

/* Returns whether any lane is not 0. */
static inline SFIELD__IN_KERNEL int sfield__any_lane(sfield__lanes a)
{
    return sfield__mask_any(sfield__lanes_differ(a, sfield__lanes_all(0)));
}

/* Fills the texels of a face with T = max(0, cos) x solid angle, and notes the blocks in which T is not 0.
   Returns 0 if there is no such block. */
SFIELD__KERNEL static int sfield__face_start(sfield__bundle *b, const float *texel, uint32_t n)
{
    const sfield__lanes x = sfield__lanes_load(b->n), y = sfield__lanes_load(b->n + 16);
    const sfield__lanes z = sfield__lanes_load(b->n + 32);
    const size_t cells = b->s->cells;
    const uint32_t block = n < SFIELD__BLOCK ? n : (uint32_t)SFIELD__BLOCK;
    uint32_t i, k, any = 0;
    for (i = 0; i < n; i += block) {
        static const uint8_t corner[4] = { 0, 21, 42, 63 };
        sfield__lanes sum = sfield__lanes_all(0);
        for (k = 0; k < 4 && block == SFIELD__BLOCK; k++) {
            const float *q = texel + i + corner[k];
            sfield__lanes d = sfield__lanes_mul(x, sfield__lanes_all(q[0]));
            d = sfield__lanes_muladd(y, sfield__lanes_all(q[cells]), d);
            d = sfield__at_least_0(sfield__lanes_muladd(z, sfield__lanes_all(q[2 * cells]), d));
            sum = sfield__lanes_add(sum, d);
        }
        b->live[i / block] = (uint8_t)(block < SFIELD__BLOCK || sfield__any_lane(sum));
        any |= b->live[i / block];
        if (!b->live[i / block]) continue;          /* all corners, so all of it, below the horizon of all */
        for (k = i; k < i + block; k++) {
            const float *q = texel + k;
            sfield__lanes d = sfield__lanes_mul(x, sfield__lanes_all(q[0]));
            d = sfield__lanes_muladd(y, sfield__lanes_all(q[cells]), d);
            d = sfield__at_least_0(sfield__lanes_muladd(z, sfield__lanes_all(q[2 * cells]), d));
            d = sfield__lanes_mul(d, sfield__lanes_all(q[3 * cells]));
            sfield__lanes_store(b->t + 16 * (size_t)k, d);
        }
    }
    return (int)any;
}

/* Adds the part of a list that lies in this face to planes of wavelets. A square of the planes is cleared
   when it is first used. Returns how many squares are used now. */
SFIELD__KERNEL static uint32_t sfield__face_add_list(sfield__bundle *b, sfield__listing *list, uint32_t last,
                                                     uint32_t count, float factor)
{
    const sfield__lanes zero = sfield__lanes_all(0);
    const sfield__lanes weight = sfield__lanes_mul(sfield__lanes_all(factor),
                                                   sfield__lanes_load(list->weight));
    const uint32_t *e = list->e, *end = list->end, mask = b->s->side * b->s->side - 1;
    float *planes = b->w;
    uint8_t *marks = b->marks;
    for (; e < end && *e < last; e++) {
        const uint32_t index = *e >> 16 & mask;
        uint32_t square = (index - 1) / 3;
        float *w = planes + 16 * (size_t)index;
        for (; index && !marks[square]; square = (square - 1) / 4) {
            float *first = planes + 16 * (size_t)(3 * square + 1);
            marks[square] = 1;
            b->used[count++] = (uint16_t)square;
            sfield__lanes_store(first, zero);
            sfield__lanes_store(first + 16, zero);
            sfield__lanes_store(first + 32, zero);
            if (!square) break;
        }
        sfield__lanes_store(w, sfield__lanes_muladd(sfield__lanes_all(sfield__signed_short(*e)), weight,
                                                 sfield__lanes_load(w)));
    }
    list->e = e;
    return count;
}

/* Multiplies the n texels of square i by 1 - mean, but for blocks in which T is 0. */
SFIELD__KERNEL static void sfield__face_dim(const sfield__bundle *b, uint32_t i, uint32_t n,
                                            const sfield__lanes *mean)
{
    const sfield__lanes keep = sfield__lanes_sub(sfield__lanes_all(1), *mean);
    uint32_t k;
    float *t;
    for (k = i * n; k < (i + 1) * n; k++) {
        if (n >= SFIELD__BLOCK && k % SFIELD__BLOCK == 0 && !b->live[k / SFIELD__BLOCK]) {
            k += SFIELD__BLOCK - 1;
            continue;
        }
        t = b->t + 16 * (size_t)k;
        sfield__lanes_store(t, sfield__lanes_mul(sfield__lanes_load(t), keep));
    }
}

/* Does for sixteen points what sfield__shade_square does for one: multiplies the texels of a marked square
   by 1 - the function below the square. */
SFIELD__KERNEL static void sfield__face_darken(const sfield__bundle *b, uint32_t leaves,
                                               const sfield__lanes *mean, uint32_t squares, uint32_t i,
                                               float scale)
{
    const sfield__lanes s = sfield__lanes_all(scale), one = sfield__lanes_all(1);
    const float *w = b->w + 16 * (size_t)(squares + 3 * i);
    const sfield__lanes x = sfield__lanes_mul(s, sfield__lanes_load(w));
    const sfield__lanes y = sfield__lanes_mul(s, sfield__lanes_load(w + 16));
    const sfield__lanes z = sfield__lanes_mul(s, sfield__lanes_load(w + 32));
    const sfield__lanes a = sfield__lanes_add(*mean, y), d = sfield__lanes_sub(*mean, y);
    const sfield__lanes f = sfield__lanes_add(x, z), g = sfield__lanes_sub(x, z);
    const uint32_t n = leaves / squares, below = (4 * squares - 1) / 3 + 4 * i;
    sfield__lanes m[4];
    uint32_t k;
    if (4 * n == SFIELD__BLOCK && !b->live[i]) return;
    m[0] = sfield__lanes_add(a, f);
    m[1] = sfield__lanes_sub(a, f);
    m[2] = sfield__lanes_add(d, g);
    m[3] = sfield__lanes_sub(d, g);
    for (k = 0; k < 4; k++) {
        float *t = b->t + 16 * (size_t)(4 * i + k);
        if (n == 1)
            sfield__lanes_store(t, sfield__lanes_mul(sfield__lanes_load(t), sfield__lanes_sub(one, m[k])));
        else if (b->marks[below + k]) sfield__face_darken(b, leaves, &m[k], 4 * squares, 4 * i + k,
                                                          2 * scale);
        else if (sfield__any_lane(m[k])) sfield__face_dim(b, 4 * i + k, n, &m[k]);
    }
}

/* Multiplies T by the visibility of an occluder. Returns 0 if the occluder hides nothing in this face. */
SFIELD__KERNEL static int sfield__face_hide(sfield__bundle *b, sfield__strand *strand, const sfield_field *f,
                                            uint32_t last, uint32_t leaves)
{
    const float scale = 1 / (float)b->s->side;
    uint32_t i, count = 0;
    sfield__lanes mean;
    for (i = 0; i < strand->count && !(strand->list[i].e < strand->list[i].end &&
                                       *strand->list[i].e < last);) i++;
    if (i == strand->count) return 0;
    sfield__lanes_store(b->w, sfield__lanes_all(0));
    for (i = 0; i < strand->count; i++)
        count = sfield__face_add_list(b, &strand->list[i], last, count,
                                      f->sample_scale[strand->list[i].sample]);
    mean = sfield__lanes_mul(sfield__lanes_load(b->w), sfield__lanes_all(scale));
    if (b->marks[0]) sfield__face_darken(b, leaves, &mean, 1, 0, scale);
    else sfield__face_dim(b, 0, 4 * leaves, &mean);
    for (i = 0; i < count; i++) b->marks[b->used[i]] = 0;
    return 1;
}

/* Transforms the squares of a level: wavelets go to out, scaling coefficients to up. */
SFIELD__KERNEL static void sfield__face_level(const float *c, uint32_t squares, float *up, float *out)
{
    const sfield__lanes half = sfield__lanes_all(0.5f);
    for (; squares > 0; squares--, c += 64, up += 16, out += 48) {
        const sfield__lanes p = sfield__lanes_load(c), q = sfield__lanes_load(c + 16);
        const sfield__lanes r = sfield__lanes_load(c + 32), s = sfield__lanes_load(c + 48);
        const sfield__lanes a = sfield__lanes_add(p, q), b = sfield__lanes_sub(p, q);
        const sfield__lanes d = sfield__lanes_add(r, s), e = sfield__lanes_sub(r, s);
        sfield__lanes_store(out, sfield__lanes_mul(half, sfield__lanes_add(b, e)));
        sfield__lanes_store(out + 16, sfield__lanes_mul(half, sfield__lanes_sub(a, d)));
        sfield__lanes_store(out + 32, sfield__lanes_mul(half, sfield__lanes_sub(b, e)));
        sfield__lanes_store(up, sfield__lanes_mul(half, sfield__lanes_add(a, d)));
    }
}

/* Finds the wavelets of the face. Blocks of up to 64 texels are transformed one by one, since a block fits
   into the nearest cache. */
SFIELD__KERNEL static void sfield__face_transform(sfield__bundle *b, uint32_t n)
{
    const uint32_t block = n < SFIELD__BLOCK ? n : (uint32_t)SFIELD__BLOCK;
    float sums[16 * SFIELD__BLOCK], part[16 * 21];
    uint32_t i, squares;
    for (i = 0; i < n / block; i++) {
        const float *from = b->t + 16 * (size_t)(i * block);
        float *up = part;
        for (squares = block / 4; squares; squares /= 4) {
            const size_t all = (size_t)squares * (n / block), at = all + 3 * (size_t)squares * i;
            if (b->live[i])
                sfield__face_level(from, squares, squares == 1 ? sums + 16 * i : up, b->w + 16 * at);
            else memset(b->w + 16 * at, 0, 48 * (size_t)squares * sizeof *b->w);
            from = up;
            up += 16 * squares;
        }
        if (!b->live[i]) memset(sums + 16 * i, 0, 16 * sizeof *sums);
    }
    for (squares = n / block / 4; squares; squares /= 4)      /* a sum falls on one that is done */
        sfield__face_level(sums, squares, sums, b->w + 16 * (size_t)squares);
    memcpy(b->w, sums, 16 * sizeof *sums);
}

/* Adds what a light gives in this face: the products of its wavelets with those of T, which are found
   first if T has changed. */
SFIELD__KERNEL static void sfield__face_light(sfield__bundle *b, sfield__strand *strand,
                                              const sfield_field *f, uint32_t last, uint32_t n, int *fresh)
{
    const float *tint = b->s->item[strand->item].e.tint;
    sfield__lanes sum[3];
    uint32_t i, c;
    for (c = 0; c < 3; c++) sum[c] = sfield__lanes_all(0);
    for (i = 0; i < strand->count; i++) {
        sfield__listing *l = &strand->list[i];
        const sfield__lanes weight = sfield__lanes_mul(sfield__lanes_all(f->sample_scale[l->sample]),
                                                     sfield__lanes_load(l->weight));
        for (; l->e < l->end && l->e[0] < last; l->e += 2) {
            sfield__lanes t;
            if (!*fresh) sfield__face_transform(b, n);
            *fresh = 1;
            t = sfield__lanes_mul(weight, sfield__lanes_load(b->w + 16 * (size_t)(l->e[0] >> 16 & (n - 1))));
            sum[0] = sfield__lanes_muladd(t, sfield__lanes_all(sfield__signed_short(l->e[0])), sum[0]);
            sum[1] = sfield__lanes_muladd(t, sfield__lanes_all(sfield__signed_short(l->e[1] >> 16)), sum[1]);
            sum[2] = sfield__lanes_muladd(t, sfield__lanes_all(sfield__signed_short(l->e[1])), sum[2]);
        }
    }
    for (c = 0; c < 3; c++) {
        float *to = b->rgb + 16 * c;
        sfield__lanes_store(to, sfield__lanes_muladd(sfield__lanes_all(tint[c]), sum[c],
                                                     sfield__lanes_load(to)));
    }
}

/* Adds what T leaves of the sky, and of a sky that is white. */
SFIELD__KERNEL static void sfield__face_finish(sfield__bundle *b, const float *sky, uint32_t n)
{
    const size_t cells = b->s->cells;
    const uint32_t block = n < SFIELD__BLOCK ? n : (uint32_t)SFIELD__BLOCK;
    const int ambient = b->ambient;
    sfield__lanes x = sfield__lanes_all(0), y = x, z = x, sum = x;
    uint32_t i, k;
    for (i = 0; i < n; i += block) {
        const float *q = sky + i, *from = b->t + 16 * (size_t)i;
        if (!b->live[i / block]) continue;
        for (k = 0; k < block; k++) {
            const sfield__lanes t = sfield__lanes_load(from + 16 * (size_t)k);
            x = sfield__lanes_muladd(t, sfield__lanes_all(q[k]), x);
            y = sfield__lanes_muladd(t, sfield__lanes_all(q[cells + k]), y);
            z = sfield__lanes_muladd(t, sfield__lanes_all(q[2 * cells + k]), z);
        }
        for (k = 0; k < block && ambient; k++)
            sum = sfield__lanes_add(sum, sfield__lanes_load(from + 16 * (size_t)k));
    }
    if (b->s->has_sky || b->s->has_sun) {
        sfield__lanes_store(b->rgb, sfield__lanes_add(x, sfield__lanes_load(b->rgb)));
        sfield__lanes_store(b->rgb + 16, sfield__lanes_add(y, sfield__lanes_load(b->rgb + 16)));
        sfield__lanes_store(b->rgb + 32, sfield__lanes_add(z, sfield__lanes_load(b->rgb + 32)));
    }
    sfield__lanes_store(b->open, sfield__lanes_add(sum, sfield__lanes_load(b->open)));
}

/* Shades one face for all points of a bundle: T is started, then goes through the entities from near to
   far. */
SFIELD__KERNEL static void sfield__face_shade(sfield__bundle *b, const sfield_field *self, uint32_t face)
{
    const sfield_scene *s = b->s;
    const uint32_t n = s->side * s->side, first = face * n << 16, last = (face + 1) * n << 16;
    uint32_t i, k;
    int fresh = 0;                          /* b->w are the wavelets of b->t */
    if (!sfield__face_start(b, s->texel + face * n, n)) return;
    for (i = 0; i < b->strands; i++) {
        sfield__strand *strand = &b->strand[i];
        const sfield_entity *e = strand->light < -1 ? NULL : &s->item[strand->item].e;
        const sfield_field *f = !e ? self : strand->light < 0 ? e->occlusion : e->source;
        for (k = 0; k < strand->count; k++)
            while (strand->list[k].e < strand->list[k].end && *strand->list[k].e < first)
                strand->list[k].e += f->h.stride;
        if (strand->light >= 0) sfield__face_light(b, strand, f, last, n, &fresh);
        else if (sfield__face_hide(b, strand, f, last, n / 4)) fresh = 0;
    }
    sfield__face_finish(b, s->sky_now + face * n, n);
}

/* ==== src/shadowfield/kernels_texels.h ==== */

/* ---- kernels: wavelets of one point, sixteen texels at a time ---- */

/* See sfield__haar_squares16. A square is four lanes, and two steps of sums and differences of neighbours
   make of its texels the scaling coefficient and the three wavelets, in the order in which they are
   stored. Squares are taken from the last to the first: the scaling coefficient falls on the wavelet
   before, which is written next. */
SFIELD__KERNEL static void sfield__haar_squares(uint32_t squares, const float *c, float *up, float *out)
{
    const sfield__lanes one = sfield__lanes_all(1), minus = sfield__lanes_all(-1);
    const sfield__lanes odd = sfield__lanes_select(sfield__mask_of_bits(0xaaaau), minus, one);
    const sfield__lanes high = sfield__lanes_select(sfield__mask_of_bits(0xccccu), minus, one);
    const sfield__lanes half = sfield__lanes_all(0.5f);
    float four[16];
    uint32_t i, k;
    for (i = squares; i > 0; i -= 4) {
        sfield__lanes x = sfield__lanes_load(c + 4 * (size_t)i - 16);
        x = sfield__lanes_muladd(x, odd, sfield__lanes_swap_ones(x));
        x = sfield__lanes_mul(half, sfield__lanes_muladd(x, high, sfield__lanes_swap_twos(x)));
        sfield__lanes_store(four, x);
        for (k = 4; k > 0; k--) {
            float *to = out + squares + 3 * (size_t)(i + k - 5) - 1;
            memcpy(to, four + 4 * k - 4, 4 * sizeof *four);
            up[i + k - 5] = four[4 * k - 4];
        }
    }
}

/* See sfield__fill_cosines16. */
SFIELD__KERNEL static void sfield__fill_cosines(const float *texel, uint32_t cells, const float *n, float *t)
{
    const sfield__lanes a = sfield__lanes_all(n[0]), b = sfield__lanes_all(n[1]), c = sfield__lanes_all(n[2]);
    const float *end = texel + cells;
    for (; texel < end; texel += 16, t += 16) {
        sfield__lanes d = sfield__lanes_mul(a, sfield__lanes_load(texel));
        d = sfield__lanes_add(d, sfield__lanes_mul(b, sfield__lanes_load(texel + cells)));
        d = sfield__lanes_add(d, sfield__lanes_mul(c, sfield__lanes_load(texel + 2 * (size_t)cells)));
        d = sfield__lanes_max(d, sfield__lanes_all(0));
        sfield__lanes_store(t, sfield__lanes_mul(d, sfield__lanes_load(texel + 3 * (size_t)cells)));
    }
}

/* See sfield__dot_sky16. Two channels share the lanes. */
SFIELD__KERNEL static void sfield__dot_sky(const float *sky, const float *t, uint32_t cells, float *sum)
{
    const float *end = t + cells;
    sfield__lanes a = sfield__lanes_all(0), b = a;
    for (; t < end; t += 8, sky += 8) {
        const float *blue = sky + 2 * (size_t)cells;
        const sfield__lanes x = sfield__lanes_load_halves(t, t);
        a = sfield__lanes_muladd(x, sfield__lanes_load_halves(sky, sky + cells), a);
        b = sfield__lanes_muladd(x, sfield__lanes_load_halves(blue, blue), b);
    }
    sfield__lanes_store(sum, a);
    sfield__lanes_store(sum + 16, b);
}

/* Multiplies n texels, a multiple of 16, by 1 - mean. */
SFIELD__KERNEL static void sfield__dim_texels(float *t, uint32_t n, float mean)
{
    const sfield__lanes keep = sfield__lanes_all(1 - mean);
    const float *end = t + n;
    for (; t < end; t += 16) sfield__lanes_store(t, sfield__lanes_mul(sfield__lanes_load(t), keep));
}

/* Multiplies the sixteen texels of four squares of the finest level by 1 - the function there. w: the
   wavelets of the squares, 0 where they have none; mean: the means of the squares. */
static inline SFIELD__IN_KERNEL void sfield__shade_fours(const float *w, const float *mean, float scale,
                                                         float *t)
{
    const sfield__lanes one = sfield__lanes_all(1), minus = sfield__lanes_all(-1);
    const sfield__lanes by = sfield__lanes_all(scale);
    const sfield__lanes x = sfield__lanes_select(sfield__mask_of_bits(0xaaaau), minus, one);
    const sfield__lanes y = sfield__lanes_select(sfield__mask_of_bits(0xccccu), minus, one);
    const sfield__lanes z = sfield__lanes_mul(x, y);
    sfield__lanes m = sfield__lanes_load_fours(mean, 1);
    m = sfield__lanes_muladd(x, sfield__lanes_mul(by, sfield__lanes_load_fours(w, 3)), m);
    m = sfield__lanes_muladd(y, sfield__lanes_mul(by, sfield__lanes_load_fours(w + 1, 3)), m);
    m = sfield__lanes_muladd(z, sfield__lanes_mul(by, sfield__lanes_load_fours(w + 2, 3)), m);
    sfield__lanes_store(t, sfield__lanes_mul(sfield__lanes_load(t), sfield__lanes_sub(one, m)));
}

/* Multiplies the texels of square i of a level by 1 - the function below the square, which is marked.
   leaves: the squares of the finest level; scale: 1 / side of the texels of a face, times the level's
   squares along a side. */
SFIELD__KERNEL static void sfield__shade_square(const float *coefs, const uint8_t *marks, uint32_t leaves,
                                                float mean, uint32_t squares, uint32_t i, float scale,
                                                float *t)
{
    const float *w = coefs + squares + 3 * (size_t)i;
    const uint8_t *below = marks + (4 * squares - 1) / 3 + 4 * i;
    const uint32_t n = leaves / squares;
    const float x = scale * w[0], y = scale * w[1], z = scale * w[2];
    float m[4];
    uint32_t k;
    m[0] = mean + x + y + z;
    m[1] = mean - x + y - z;
    m[2] = mean + x - y - z;
    m[3] = mean - x - y + z;
    if (n == 4) {
        sfield__shade_fours(coefs + 4 * squares + 12 * (size_t)i, m, 2 * scale, t + 16 * (size_t)i);
        return;
    }
    for (k = 0; k < 4; k++) {
        const uint32_t quarter = 4 * i + k;
        if (below[k]) sfield__shade_square(coefs, marks, leaves, m[k], 4 * squares, quarter, 2 * scale, t);
        else if (m[k] != 0) sfield__dim_texels(t + (size_t)quarter * n, n, m[k]);
    }
}

/* See sfield__darken16. */
SFIELD__KERNEL static void sfield__darken(const float *coefs, const uint8_t *marks, uint32_t side, float *t)
{
    const float scale = 1 / (float)side, mean = coefs[0] / (float)side;
    if (marks[0]) sfield__shade_square(coefs, marks, side * side / 4, mean, 1, 0, scale, t);
    else if (mean != 0) sfield__dim_texels(t, side * side, mean);
}

/* ==== src/shadowfield/kernels_end.h ==== */

#undef SFIELD__SET
#undef SFIELD__WIDTH
#undef SFIELD__LANE_COUNT
#endif /* SFIELD__SET */

#if defined(SHADOWFIELD_IMPLEMENTATION) && !defined(SHADOWFIELD_IMPLEMENTED)
#define SHADOWFIELD_IMPLEMENTED

/* ---- kernels: those of other instruction sets, and which to call ---- */

#if SFIELD__SIMD_SETS
#define SFIELD__SET avx2
#define SFIELD__WIDTH 8
#define SFIELD__LANE_COUNT 16
#include SFIELD__FILE
#define SFIELD__SET avx512
#define SFIELD__WIDTH 16
#define SFIELD__LANE_COUNT 16
#include SFIELD__FILE
#endif

static void sfield__product16(const sfield_algebra *t, const float *a, const float *b, float *out,
                              size_t stride, int occlude)
{
#if SFIELD__SIMD_SETS
    if (t->simd == 2) {
        (t->bands == 4 ? sfield__product4_avx512 : sfield__product_avx512)(t, a, b, out, stride, occlude);
        return;
    }
    if (t->simd == 1) {
        (t->bands == 4 ? sfield__product4_avx2 : sfield__product_avx2)(t, a, b, out, stride, occlude);
        return;
    }
#endif
    sfield__product_plain(t, a, b, out, stride, occlude);
}

static void sfield__rotate16(const sfield_rotation *r, const float *in, float *out, size_t stride,
                             int inverse, int simd)
{
#if SFIELD__SIMD_SETS
    if (simd == 2) {
        (r->bands == 4 ? sfield__rotate4_avx512 : sfield__rotate_avx512)(r, in, out, stride, inverse);
        return;
    }
    if (simd == 1) {
        (r->bands == 4 ? sfield__rotate4_avx2 : sfield__rotate_avx2)(r, in, out, stride, inverse);
        return;
    }
#endif
    (void)simd;
    (r->bands == 4 ? sfield__rotate4_plain : sfield__rotate_plain)(r, in, out, stride, inverse);
}

/* Calls a kernel of the best instruction set there is. */
#if SFIELD__SIMD_SETS
#define SFIELD__CALL_BEST(kernel, simd, arguments)                                                         \
    ((simd) == 2 ? kernel##_avx512 arguments                                                               \
                 : (simd) == 1 ? kernel##_avx2 arguments : kernel##_plain arguments)
#else
#define SFIELD__CALL_BEST(kernel, simd, arguments) ((void)(simd), kernel##_plain arguments)
#endif

/* Calls a kernel that has no text of its own for AVX-512. */
#if SFIELD__SIMD_SETS
#define SFIELD__CALL(kernel, simd, arguments) ((simd) ? kernel##_avx2 arguments : kernel##_plain arguments)
#else
#define SFIELD__CALL(kernel, simd, arguments) ((void)(simd), kernel##_plain arguments)
#endif

static void sfield__mix_samples(const sfield_field *f, const sfield__between *at, uint32_t n, float *out,
                                int simd)
{
    SFIELD__CALL_BEST(sfield__mix, simd, (f, at, n, out));
}

static void sfield__widen_samples(const sfield_field *f, const uint8_t *first, uint32_t n, float *out,
                                  int simd)
{
    SFIELD__CALL_BEST(sfield__widen, simd, (f, first, n, out));
}

static void sfield__rows_to_planes(const float *rows, size_t stride, uint32_t n, float *planes, int simd)
{
    SFIELD__CALL_BEST(sfield__transpose, simd, (rows, stride, n, planes));
}

/* Interpolates between eight samples, for the lanes by their factors, into planes; unless more is 0 the
   coefficients are added to what the planes hold. */
static void sfield__mix_eight(const sfield__eight *c, const sfield__place *at, const float *factor, int more,
                              float *out, int simd)
{
    SFIELD__CALL_BEST(sfield__eight_to_planes, simd, (c, at, factor, more, out));
}

/* Adds to sum each lane's dot product of t, in planes, with what lies between eight samples. */
static void sfield__dot_eight(const sfield__eight *c, const sfield__place *at, const float *factor,
                              const float *t, float *sum, int simd)
{
    SFIELD__CALL_BEST(sfield__eight_times, simd, (c, at, factor, t, sum));
}

/* Does what sfield__dot_eight does for lanes that each lie between samples of their own, in a frame of a
   source: n coefficients, a multiple of 8, from number `from` on. room: 32 n floats. */
static void sfield__dot_single(const sfield_field *f, const sfield__place *at, uint32_t frame,
                               const float *factor, uint32_t from, uint32_t n, const float *t, float *room,
                               float *sum, int simd)
{
    SFIELD__CALL_BEST(sfield__singles_times, simd, (f, at, frame, factor, from, n, t, room, sum));
}

static void sfield__locate16(const sfield_field *f, const float *p, sfield__place *out, int simd)
{
    SFIELD__CALL(sfield__locate, simd, (f, p, out));
}

static uint32_t sfield__same16(const int32_t *base, int32_t wanted, int simd)
{
    return SFIELD__CALL(sfield__same_eight, simd, (base, wanted));
}

static void sfield__select16(const float *in, uint32_t n, uint32_t mask, float *out, int simd)
{
    SFIELD__CALL(sfield__select, simd, (in, n, mask, out));
}

static void sfield__to_local16(const float *m, const float *c, float f, const float *p, float *local,
                               int simd)
{
    SFIELD__CALL(sfield__to_local, simd, (m, c, f, p, local));
}

static uint32_t sfield__nearer16(const float *a, const float *b, int simd)
{
    return SFIELD__CALL(sfield__nearer, simd, (a, b));
}

static uint32_t sfield__look_at16(const float *p, const float *n, const float *c, float reach2, float low,
                                  float *d2, int simd)
{
    return SFIELD__CALL(sfield__look_at, simd, (p, n, c, reach2, low, d2));
}

static void sfield__fade16(const float *d2, float inverse_reach, uint32_t lanes, float *factor, int simd)
{
    SFIELD__CALL(sfield__fade, simd, (d2, inverse_reach, lanes, factor));
}

static void sfield__recall16(const int16_t *value, const float *scale, uint32_t n, float *t, int simd)
{
    SFIELD__CALL_BEST(sfield__recall, simd, (value, scale, n, t));
}

#ifndef SFIELD_WITHOUT_BUILD
static void sfield__draw_triangles16(const sfield__build *b, sfield__view *v, const float *eye)
{
    SFIELD__CALL_BEST(sfield__draw_triangles, b->simd, (b, v, eye));
}

static void sfield__find_crossings16(const sfield__build *b, const float *eye, sfield__inside_ray *ray)
{
    SFIELD__CALL_BEST(sfield__find_crossings, b->simd, (b, eye, ray));
}
#endif

#ifndef SFIELD_WITHOUT_WAVELETS
static void sfield__haar_squares16(uint32_t squares, const float *c, float *up, float *out, int simd)
{
    SFIELD__CALL_BEST(sfield__haar_squares, simd, (squares, c, up, out));
}

/* Writes max(0, cos) x solid angle of each texel. texel: four planes of cells, directions and solid
   angles. */
static void sfield__fill_cosines16(const float *texel, uint32_t cells, const float *n, float *t, int simd)
{
    SFIELD__CALL_BEST(sfield__fill_cosines, simd, (texel, cells, n, t));
}

/* Writes the dot products of T with the three channels of a sky: for each channel eight sums, of every eighth
   texel. The last eight of 32 floats mean nothing. */
static void sfield__dot_sky16(const float *sky, const float *t, uint32_t cells, float *sum, int simd)
{
    SFIELD__CALL_BEST(sfield__dot_sky, simd, (sky, t, cells, sum));
}

/* Multiplies the texels of a face by 1 - the function that its coefficients are. marks: the squares that have
   wavelets, or squares with wavelets below them. */
static void sfield__darken16(const float *coefs, const uint8_t *marks, uint32_t side, float *t, int simd)
{
    SFIELD__CALL_BEST(sfield__darken, simd, (coefs, marks, side, t));
}
#endif

/* ==== src/shadowfield/wavelets_scene.h ==== */

/* ---- wavelets: cubes of texels turned ---- */

/* Finds the four texels of a cube that lie around a direction, with their bilinear weights. */
static void sfield__find_taps(const sfield_scene *s, const float *direction, sfield__taps *taps)
{
    const uint32_t face = sfield__face_of(direction);
    float q[3], d[3], x, y;
    int32_t xi, yi;
    uint32_t k;
    sfield__to_face(face, direction, q);
    x = (q[0] / q[2] + 1) * 0.5f * (float)s->side - 0.5f;
    y = (q[1] / q[2] + 1) * 0.5f * (float)s->side - 0.5f;
    xi = (int32_t)(x + 1) - 1;
    yi = (int32_t)(y + 1) - 1;
    x -= (float)xi;
    y -= (float)yi;
    /* past an edge: the texel of the next face in that direction */
    for (k = 0; k < 4; k++) {
        double e[3];
        sfield__from_face(face, (2.0 * (xi + (int32_t)(k & 1)) + 1) / s->side - 1,
                          (2.0 * (yi + (int32_t)(k >> 1)) + 1) / s->side - 1, e);
        d[0] = (float)e[0];
        d[1] = (float)e[1];
        d[2] = (float)e[2];
        taps->texel[k] = (uint16_t)sfield_cube_find(s->side, d);
        taps->weight[k] = (k & 1 ? x : 1 - x) * (k >> 1 ? y : 1 - y);
    }
}

/* Finds the texels around texel i of the scene's cube, seen through a rotation: rows of three floats,
   `stride` apart. */
static void sfield__find_turned_taps(const sfield_scene *s, const float *turn, uint32_t stride, uint32_t i,
                                 sfield__taps *taps)
{
    const float x = s->texel[i], y = s->texel[s->cells + i], z = s->texel[2 * s->cells + i];
    float local[3];
    uint32_t k;
    for (k = 0; k < 3; k++, turn += stride) local[k] = turn[0] * x + turn[1] * y + turn[2] * z;
    sfield__find_taps(s, local, taps);
}

/* Finds, for a rotated entity, which texels of its own cube lie around each direction of the world's. */
static void sfield__make_taps(const sfield_scene *s, const float *turn, sfield__taps *taps)
{
    uint32_t i;
    for (i = 0; i < s->cells; i++) sfield__find_turned_taps(s, turn, 3, i, &taps[i]);
}

/* Makes a table for each entity that is rotated and hides or shines. Returns 0 if there is no memory. */
static int sfield__make_all_taps(sfield_scene *s, uint32_t tables)
{
    uint32_t i;
    s->taps = (sfield__taps *)sfield__alloc_array(&s->allocator, (size_t)tables * s->cells, sizeof *s->taps);
    if (!s->taps) return 0;
    for (i = 0; i < s->item_count; i++)
        if (s->item[i].map)
            sfield__make_taps(s, s->item[i].turn, s->taps + (size_t)(s->item[i].map - 1) * s->cells);
    return 1;
}

/* Resamples the sky's cube as it lies in the world now, and finds its wavelets. */
static void sfield__turn_cube(sfield_scene *s)
{
    uint32_t i, c, k;
    for (i = 0; i < s->cells; i++) {
        sfield__taps taps;
        sfield__find_turned_taps(s, s->sky_turn, 4, i, &taps);
        for (c = 0; c < 3; c++) s->sky_now[c * s->cells + i] = s->sun[c * s->cells + i];
        for (k = 0; k < 4; k++)
            for (c = 0; c < 3; c++)
                s->sky_now[c * s->cells + i] += taps.weight[k] * s->sky[c * s->cells + taps.texel[k]];
    }
    for (c = 0; c < 3; c++)
        sfield__haar_cube(s->side, s->sky_now + c * s->cells, s->sky_now + (3 + c) * s->cells, s->simd);
}

/* ==== src/shadowfield/scene_tree.h ==== */

/* ---- scenes: which occluders lie near ---- */

/* Occluders lie along a Morton curve, and four in a row that begin at a multiple of four, sixteen, and so on,
   have a sphere about all that they reach. Whoever looks for occluders walks past those whose sphere is far
   away, so that scenes of many bodies cost what lies near a point. It finds all that matter, and others: the
   exact tests come after it. */

/* Sorts a, which is n numbers long, by way of b. Returns where the result is, a or b. */
static uint64_t *sfield__sort_keys(uint64_t *a, uint64_t *b, uint32_t n)
{
    uint32_t width, i, end;
    for (width = 1; width < n; width *= 2) {
        uint64_t *swap = a;
        for (i = 0; i < n; i += 2 * width) {
            const uint32_t middle = n - i < width ? n : i + width;
            uint32_t j = i, k = middle;
            end = n - middle < width ? n : middle + width;
            for (; j < middle || k < end; b++)
                *b = k == end || (j < middle && a[j] < a[k]) ? a[j++] : a[k++];
        }
        a = b - n;
        b = swap;
    }
    return a;
}

/* Finds a sphere about all that some occluders reach. */
static sfield__ball sfield__bound_reach(const sfield_scene *s, const uint64_t *order, uint32_t count)
{
    sfield__ball ball = { { 0, 0, 0 }, 0 };
    uint32_t i, k;
    for (k = 0; k < 3; k++) {
        float low = s->item[(uint32_t)order[0]].center[0][k], high = low;
        for (i = 1; i < count; i++) {
            const float x = s->item[(uint32_t)order[i]].center[0][k];
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        ball.center[k] = 0.5f * low + 0.5f * high;
    }
    for (i = 0; i < count; i++) {
        const sfield__item *it = &s->item[(uint32_t)order[i]];
        const sfield__v3 c = sfield__v3_load(it->center[0]);
        const float r = it->reach + sfield__v3_length(sfield__v3_sub(c, sfield__v3_load(ball.center)));
        ball.radius = r <= ball.radius ? ball.radius : r;       /* no number: never far */
    }
    return ball;
}

/* Writes the place along a Morton curve of each occluder's center, and below it which it is. */
static void sfield__place_on_curve(const sfield_scene *s, uint64_t *key)
{
    uint32_t i, k, b;
    for (i = 0; i < s->occluder_count; i++) key[i] = s->occluder[i];
    for (k = 0; k < 3; k++) {
        float low = 3e38f, high = -3e38f, scale;
        for (i = 0; i < s->occluder_count; i++) {
            const float x = s->item[s->occluder[i]].center[0][k];
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        scale = high > low ? 1023 / (high - low) : 0;
        for (i = 0; i < s->occluder_count; i++) {
            const float x = (s->item[s->occluder[i]].center[0][k] - low) * scale;
            const uint32_t at = x > 0 ? x < 1023 ? (uint32_t)x : 1023u : 0u;
            for (b = 0; b < 10; b++) key[i] |= (uint64_t)(at >> b & 1u) << (32 + 3 * b + k);
        }
    }
}

/* Makes the spheres of a scene whose items are there. Returns 0 if there is no memory. */
static int sfield__make_tree(sfield_scene *s)
{
    sfield__tree *t = &s->tree;
    const uint32_t n = t->count = s->occluder_count;
    uint32_t i, k, balls = 0;
    for (t->levels = 0; (4u << 2 * t->levels) < n; t->levels++)
        balls += (n + (4u << 2 * t->levels) - 1) >> (2 * t->levels + 2);
    t->keys = (uint64_t *)sfield__alloc_array(&s->allocator, n ? n : 1, 2 * sizeof *t->keys);
    t->ball = (sfield__ball *)sfield__alloc_array(&s->allocator, balls ? balls : 1, sizeof *t->ball);
    if (!t->keys || !t->ball) return 0;
    sfield__place_on_curve(s, t->keys);
    t->order = sfield__sort_keys(t->keys, t->keys + n, n);
    for (k = 0, balls = 0; k < t->levels; k++) {
        const uint32_t size = 4u << 2 * k;
        t->level[k] = t->ball + balls;
        for (i = 0; i < n; i += size)
            t->ball[balls++] = sfield__bound_reach(s, t->order + i, n - i < size ? n - i : size);
    }
    return 1;
}

static void sfield__start_walk(sfield__walk *w, const sfield_scene *s, const float *middle, float extent)
{
    w->tree = &s->tree;
    memcpy(w->middle, middle, sizeof w->middle);
    w->extent = extent;
    w->at = 0;
    w->level = s->tree.levels;
}

/* Returns the next occluder, by its item, that may reach a sphere, or SFIELD__NONE after the last. What it
   walks past is too far away for sure, by more than what roundings come to. */
static uint32_t sfield__next_near(sfield__walk *w)
{
    const sfield__tree *t = w->tree;
    while (w->at < t->count) {
        const uint32_t at = w->at, level = w->level;
        if (level) {
            const sfield__ball *b = &t->level[level - 1][at >> 2 * level];
            const float x = b->center[0] - w->middle[0], y = b->center[1] - w->middle[1];
            const float z = b->center[2] - w->middle[2], r = 1.0001f * (b->radius + w->extent) + 1e-18f;
            if (!(x * x + y * y + z * z > r * r)) {
                w->level--;
                continue;
            }
        }
        w->at += 1u << 2 * level;
        while (w->level < t->levels && !(w->at & ((4u << 2 * w->level) - 1))) w->level++;
        if (!level) return (uint32_t)t->order[at];
    }
    return SFIELD__NONE;
}

/* ==== src/shadowfield/scene.h ==== */

/* ---- scenes: entities, and where they are ---- */

static void sfield__free_lists(sfield_scene *s)
{
    sfield__free(&s->allocator, s->item);
    sfield__free(&s->allocator, s->rotation);
    sfield__free(&s->allocator, s->occluder);
    sfield__free(&s->allocator, s->light);
    sfield__free(&s->allocator, s->taps);
    sfield__free(&s->allocator, s->moved);
#ifndef SFIELD_WITHOUT_ROOMS
    sfield__free(&s->allocator, s->held);
#endif
#ifndef SFIELD_WITHOUT_HIERARCHY
    sfield__free(&s->allocator, s->tree.keys);
    sfield__free(&s->allocator, s->tree.ball);
#endif
}

SFIELD_DEF void sfield_scene_free(sfield_scene *s)
{
    sfield__allocator a;
    if (!s) return;
    a = s->allocator;
    sfield__free_lists(s);
    sfield_algebra_free(s->algebra);
    sfield__free(&a, s->sky);
    sfield__free(&a, s->texel);
    sfield__free(&a, s->scratch);
#ifndef SFIELD_WITHOUT_GLOSS
    sfield__free(&a, s->brdf);
#endif
    sfield__free(&a, s);
}

/* Checks a desc and fills in its defaults. */
static sfield_result sfield__read_scene_desc(sfield_scene_desc *d, int has_out)
{
    const sfield__logger log = sfield__logger_of(&d->system, "sfield_scene_create");
    const int haar = d->basis == SFIELD_BASIS_HAAR;
    if (!has_out) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "out", "is NULL");
    if (!sfield__system_good(&d->system)) return sfield__fail_allocator(&log);
    if (!sfield__check_value(&log, (uint32_t)d->basis < SFIELD_BASIS_COUNT, "desc.basis", (double)d->basis,
                             "0..2") ||
        !sfield__check_value(&log, (uint32_t)d->product < SFIELD_PRODUCT_COUNT, "desc.product",
                             (double)d->product, "0..4") ||
        !sfield__check_value(&log, d->bands <= SFIELD_MAX_BANDS, "desc.bands", d->bands, "0..8") ||
        !sfield__check_value(&log, !d->cube_side || sfield__is_side(d->cube_side, 4), "desc.cube_side",
                             d->cube_side, "0, 4, 8, 16, 32 or 64") ||
        !sfield__check_value(&log, sfield__in(d->reach, 0, 1e6f), "desc.reach", (double)d->reach, "0..1e6"))
        return SFIELD_ERR_DESC;
#ifdef SFIELD_WITHOUT_WAVELETS
    if (haar)
        return sfield__fail(&log, SFIELD_ERR_DESC, "desc.basis",
                            "is not in this header, joined without wavelets");
#endif
#ifdef SFIELD_WITHOUT_LOGARITHMS
    if (d->product == SFIELD_PRODUCT_EXP)
        return sfield__fail(&log, SFIELD_ERR_DESC, "desc.product",
                            "is not in this header, joined without logarithms");
#endif
    if (d->product == SFIELD_PRODUCT_DEFAULT)
        d->product = haar ? SFIELD_PRODUCT_TEXELS : SFIELD_PRODUCT_TRIPLE;
    if (haar != (d->product >= SFIELD_PRODUCT_TEXELS))
        return sfield__fail(&log, SFIELD_ERR_DESC, "desc.product", "is not one of this basis");
    d->bands = d->bands ? d->bands : 4;
    d->cube_side = d->cube_side ? d->cube_side : haar ? 32 : 16;
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_scene_create(const sfield_scene_desc *desc, sfield_scene **out)
{
    sfield_scene_desc d;
    sfield_result result;
    sfield__allocator a;
    sfield_scene *s;
    uint32_t haar, i, k;
    size_t kept;
    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    result = sfield__read_scene_desc(&d, out != NULL);
    if (result != SFIELD_OK) return result;
    haar = d.basis == SFIELD_BASIS_HAAR;
    a = sfield__allocator_of(&d.system);
    s = (sfield_scene *)sfield__alloc(&a, sizeof *s);
    if (!s) return SFIELD_ERR_ALLOC;
    memset(s, 0, sizeof *s);
    s->allocator = a;
    s->desc = d;
    s->simd = sfield__simd_level();
    s->side = d.cube_side;
    s->cells = 6 * s->side * s->side;
    s->coefs = haar ? s->cells : d.bands * d.bands;
    s->planes = haar ? s->cells : sfield__planes(d.bands);
    kept = 3 * (size_t)s->cells + 3 * (size_t)s->planes * 3;
    s->sky = (float *)sfield__alloc_array(&a, kept, sizeof *s->sky);
    s->texel = (float *)sfield__alloc_array(&a, 4 * (size_t)s->cells, sizeof *s->texel);
    if (!s->sky || !s->texel ||
        (!haar && sfield_algebra_create(d.bands, &d.system, &s->algebra) != SFIELD_OK)) {
        sfield_scene_free(s);
        return SFIELD_ERR_ALLOC;
    }
    memset(s->sky, 0, kept * sizeof *s->sky);
    s->sky_now = s->sky + 3 * s->cells;
    s->sky_still = s->sky_now + 3 * (size_t)s->planes;
    s->sun = s->sky_still + 3 * (size_t)s->planes;
    for (i = 0; i < s->cells; i++) {
        float dir[3];
        s->texel[3 * s->cells + i] = sfield_cube_texel(s->side, i, dir);
        for (k = 0; k < 3; k++) s->texel[k * s->cells + i] = dir[k];
    }
    *out = s;
    return SFIELD_OK;
}

static int sfield__field_fits(const sfield_scene *s, const sfield_field *f, sfield__kind kind)
{
    if (f->h.kind != (uint32_t)kind) return 0;
    if (f->h.basis == SFIELD_BASIS_HAAR) return s->algebra == NULL && f->h.cube_side == s->side;
    if (!s->algebra || f->h.bands != s->desc.bands) return 0;
    return kind != SFIELD__KIND_OCCLUSION || (s->desc.product == SFIELD_PRODUCT_EXP) == (f->h.logarithm != 0);
}

static void sfield__place_field(sfield__item *it, int which, const sfield_field *f, float scale)
{
    sfield__v3_store(it->center[which], sfield__m4_point(it->e.transform, sfield__v3_load(f->h.center)));
    it->radius[which] = scale * f->h.radius;
    it->inverse[which] = 1 / it->radius[which];
}

/* ---- hashes: what a cached T depends on ---- */

static uint64_t sfield__hash(uint64_t h, uint64_t x)
{
    h = (h ^ x) * 0x9e3779b97f4a7c15u;
    return h ^ h >> 29;
}

static uint64_t sfield__hash_bytes(uint64_t h, const void *data, size_t words)
{
    const uint8_t *p = (const uint8_t *)data;
    for (; words; words--, p += 4) {
        uint32_t x;
        memcpy(&x, p, sizeof x);
        h = sfield__hash(h, x);
    }
    return h;
}

/* Returns the result of an entity that cannot be used, once its line is written. */
static sfield_result sfield__fail_entity(const sfield_scene *s, sfield_result result, size_t index,
                                         const char *text)
{
    const sfield__logger log = sfield__logger_of(&s->desc.system, "sfield_scene_entities");
    return sfield__fail_at(&log, result, "entities", index, text);
}

/* Fills in the hashes of an item. They are taken here, since its fields may be freed before the next call. */
static void sfield__hash_item(sfield__item *it)
{
    const sfield_entity *e = &it->e;
    if (e->occlusion) {
        it->field = sfield__hash(e->occlusion->h.crc, (uint64_t)(uintptr_t)e->occlusion) | 1;
        it->body = sfield__hash_bytes(it->field, e->transform, 16) | 1;
    }
    if (e->source) {
        uint64_t h = sfield__hash(e->source->h.crc, (uint64_t)(uintptr_t)e->source);
        h = sfield__hash_bytes(sfield__hash_bytes(h, e->transform, 16), e->tint, 3);
        it->light = sfield__hash_bytes(h, &e->time, 1) | 1;
    }
}

static sfield_result sfield__make_item(const sfield_scene *s, const sfield_entity *e, size_t index,
                                       sfield__item *it, sfield_rotation *rotation)
{
    float scale;
    uint32_t i, k;
    memset(it, 0, sizeof *it);
    it->e = *e;
    memmove(it->e.transform, sfield__m4_or_identity(e->transform), sizeof it->e.transform);
    e = &it->e;
    if (!sfield__m4_is_rigid_uniform(e->transform, &scale))
        return sfield__fail_entity(s, SFIELD_ERR_INPUT, index,
                                   "has a transform that is no rotation with one scale > 0");
    if (!sfield__finite(e->time))
        return sfield__fail_entity(s, SFIELD_ERR_INPUT, index, "has a time that is not finite");
    it->identity = sfield__is_upright(e->transform);
    for (i = 0; i < 3; i++) {
        if (!sfield__in(e->tint[i], -1e18f, 1e18f))
            return sfield__fail_entity(s, SFIELD_ERR_INPUT, index, "has a tint beyond -1e18..1e18");
        for (k = 0; k < 3; k++)
            it->turn[3 * i + k] = it->identity ? (i == k ? 1.0f : 0.0f) : e->transform[4 * i + k] / scale;
    }
    if ((e->occlusion && e->occlusion->h.shard_end) || (e->source && e->source->h.shard_end))
        return sfield__fail_entity(s, SFIELD_ERR_MISMATCH, index,
                                   "has a field that is a shard: sfield_merge first");
    if (e->occlusion) {
        if (!sfield__field_fits(s, e->occlusion, SFIELD__KIND_OCCLUSION))
            return sfield__fail_entity(
                s, SFIELD_ERR_MISMATCH, index,
                "has an occlusion of another kind, basis, bands or logarithm than the scene");
        sfield__place_field(it, 0, e->occlusion, scale);
        it->inscribed = e->occlusion->h.inscribed * scale;
        it->reach = it->radius[0] * (s->desc.reach > 0 ? s->desc.reach
                                                       : e->occlusion->radii[e->occlusion->h.shells - 1]);
    }
    if (e->source) {
        if (!sfield__field_fits(s, e->source, SFIELD__KIND_SOURCE))
            return sfield__fail_entity(s, SFIELD_ERR_MISMATCH, index,
                                       "has a source of another kind, basis or bands than the scene");
        sfield__place_field(it, 1, e->source, scale);
    }
    sfield__hash_item(it);
    /* An entity that only receives may turn, unless it has a self-visibility. */
    if (!s->algebra) {
        const int sparse = s->desc.product == SFIELD_PRODUCT_SPARSE;
        if (sparse && !it->identity && (e->occlusion || e->source))
            return sfield__fail_entity(s, SFIELD_ERR_MISMATCH, index,
                                       "is rotated, which SFIELD_PRODUCT_SPARSE does not do");
        return SFIELD_OK;
    }
    return sfield_sh_rotation(s->algebra, e->transform, rotation);
}

/* Notes all that results depend on now. before: the hash before, if no more than occluders moved, else 0. */
static void sfield__note_change(sfield_scene *s, uint64_t before)
{
    s->before_hash = before;
    s->now_hash = sfield__hash(s->entities_hash, s->sky_hash) | 1;
}

/* Compares the new entities with those before. Notes which occluders moved, and whether nothing else has. */
static void sfield__note_moves(const sfield_scene *s, sfield_scene *n)
{
    int alike = n->item_count == s->item_count && n->item_count > 0;
    uint64_t h = n->item_count;
    uint32_t i;
    n->moved_count = 0;
    for (i = 0; i < n->item_count; i++) {
        sfield__item *now = &n->item[i];
        const sfield__item *was = alike ? &s->item[i] : now;
        h = sfield__hash(sfield__hash(h, now->body), now->light);
        memcpy(now->was, was->center[0], sizeof now->was);
        if (!alike) continue;
        alike = was->field == now->field && was->light == now->light &&
                !(was->reach < now->reach || was->reach > now->reach);
        if (now->body != was->body) n->moved[n->moved_count++] = i;
    }
    if (h == s->entities_hash && alike) {       /* nothing moved: what moved before still counts */
        for (i = 0; i < n->item_count; i++) memcpy(n->item[i].was, s->item[i].was, sizeof n->item[i].was);
        memcpy(n->moved, s->moved, s->moved_count * sizeof *s->moved);
        n->moved_count = s->moved_count;
        return;
    }
    n->entities_hash = h;
    sfield__note_change(n, alike ? s->now_hash : 0);
}

/* Makes the lists of the new scene beside the old one. */
static sfield_result sfield__make_lists(sfield_scene *n, const sfield_entity *entities, size_t count)
{
    uint32_t i, j, turned = 0, light = 0;
    size_t room = count ? count : 1;
    n->item = (sfield__item *)sfield__alloc_array(&n->allocator, room, sizeof *n->item);
    n->rotation =
        (sfield_rotation *)sfield__alloc_array(&n->allocator, n->algebra ? room : 1, sizeof *n->rotation);
    n->occluder = (uint32_t *)sfield__alloc_array(&n->allocator, room, sizeof *n->occluder);
    n->light = (uint32_t *)sfield__alloc_array(&n->allocator, room, sizeof *n->light);
    n->moved = (uint32_t *)sfield__alloc_array(&n->allocator, room, sizeof *n->moved);
    if (!n->item || !n->rotation || !n->occluder || !n->light || !n->moved) return SFIELD_ERR_ALLOC;
    for (i = 0; i < count; i++) {
        sfield__item *it = &n->item[i];
        sfield_result result = sfield__make_item(n, &entities[i], i, it, n->rotation + (n->algebra ? i : 0));
        if (result != SFIELD_OK) return result;
        if (it->e.occlusion) n->occluder[n->occluder_count++] = i;
        if (it->e.source) n->light[n->light_count++] = i;
        if (!n->algebra && !it->identity && (it->e.occlusion || it->e.source)) it->map = ++turned;
    }
#ifndef SFIELD_WITHOUT_WAVELETS
    if (turned && !sfield__make_all_taps(n, turned)) return SFIELD_ERR_ALLOC;
#endif
    n->maps = turned;
#ifndef SFIELD_WITHOUT_HIERARCHY
    if (!sfield__make_tree(n)) return SFIELD_ERR_ALLOC;
#endif
    for (i = n->light_count; i-- > 0;)
        for (j = 0; j < n->occluder_count; j++) {
            const sfield__item *a = &n->item[n->light[i]], *b = &n->item[n->occluder[j]];
            sfield__v3 d = sfield__v3_sub(sfield__v3_load(a->center[1]), sfield__v3_load(b->center[0]));
            if (a == b || !(sfield__v3_length(d) < a->radius[1] + b->radius[0])) continue;
            n->overlaps++;
            light = i;
        }
#ifndef SFIELD_WITHOUT_ROOMS
    if (n->overlaps && !sfield__find_rooms(n)) return SFIELD_ERR_ALLOC;
#endif
    if (n->overlaps && n->desc.strict)
        return sfield__fail_entity(n, SFIELD_ERR_INPUT, n->light[light],
                                   "is a light whose sphere overlaps an object's");
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_scene_entities(sfield_scene *s, const sfield_entity *entities, size_t count)
{
    sfield_scene n;
    sfield_result result;
    sfield__logger log;
    if (!s) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&s->desc.system, "sfield_scene_entities");
    if (!entities && count) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "entities", "is NULL");
    if (!sfield__check_value(&log, count <= 65535, "count", (double)count, "at most 65535"))
        return SFIELD_ERR_LIMIT;
    n = *s;
    n.item = NULL;
    n.rotation = NULL;
    n.occluder = n.light = NULL;
    n.taps = NULL;
    n.moved = NULL;
#ifndef SFIELD_WITHOUT_ROOMS
    n.held = NULL;
    n.held_count = 0;
#endif
#ifndef SFIELD_WITHOUT_HIERARCHY
    memset(&n.tree, 0, sizeof n.tree);
#endif
    n.occluder_count = n.light_count = n.overlaps = 0;
    n.item_count = (uint32_t)count;
    result = sfield__make_lists(&n, entities, count);
    if (result != SFIELD_OK) {
        sfield__free_lists(&n);
        return result;
    }
    sfield__note_moves(s, &n);
    sfield__free_lists(s);
    *s = n;
    return SFIELD_OK;
}

/* ==== src/shadowfield/scene_environment.h ==== */

/* ---- scenes: distant light ---- */

/* What a cube's texel receives: the sum of radiance times solid angle, and the least of each channel. */
typedef struct sfield__gathered { double rgb[3], angle; float least[3]; } sfield__gathered;

static void sfield__gather_cell(sfield__gathered *g, const float *rgb, double angle)
{
    uint32_t k;
    for (k = 0; k < 3; k++) {
        const float good = sfield__finite(rgb[k]) && rgb[k] > 0 ? (rgb[k] < 1e18f ? rgb[k] : 1e18f) : 0.0f;
        g->rgb[k] += angle * (double)good;
        if (g->angle == 0 || good < g->least[k]) g->least[k] = good;
    }
    g->angle += angle;
}

/* Adds every texel of the map to the texel of the cube that holds its middle. A texel of the map has one
   radiance and its exact solid angle; where the map is coarser than the cube its texels are added in parts.
   So no sun falls between samples, and none counts twice (T11, T12). */
static void sfield__gather_map(const sfield_scene *s, const float *rgb, uint32_t width, uint32_t height,
                               sfield__gathered *g)
{
    const uint32_t across = (32 * s->side + width - 1) / width, down = (16 * s->side + height - 1) / height;
    const uint32_t wide = width * across, high = height * down;
    const double step = 2 * sfield__pi / wide;
    double first[2], turn[2], half;
    double unused, sine, cosine;
    uint32_t x, y;
    sfield__sincos_d(0.5 * step - sfield__pi, &first[1], &first[0]);
    sfield__sincos_d(step, &turn[1], &turn[0]);
    sfield__sincos_d(0.5 * sfield__pi / high, &half, &unused);
    for (y = 0; y < high; y++) {
        const float *row = rgb + 3 * (size_t)(y / down) * width;
        double c = first[0], n = first[1], old, angle;
        sfield__sincos_d(sfield__pi * (y + 0.5) / high, &sine, &cosine);
        angle = step * 2 * sine * half;         /* cos of the upper edge less cos of the lower */
        for (x = 0; x < wide; x++) {
            float direction[3];
            direction[0] = (float)(sine * c);
            direction[1] = (float)cosine;
            direction[2] = (float)(sine * n);
            sfield__gather_cell(g + sfield_cube_find(s->side, direction), row + 3 * (size_t)(x / across),
                                angle);
            old = c;
            c = c * turn[0] - n * turn[1];
            n = n * turn[0] + old * turn[1];
        }
    }
}

/* Makes the cube of texels from a map. What falls into a texel of the cube covers its solid angle but for its
   edges. So the least radiance among this counts for the whole texel, and what is brighter counts by its
   energy; then the remaining error of the energy is scaled away. Returns 0 if there is no memory. */
static int sfield__take_map(sfield_scene *s, const float *rgb, uint32_t width, uint32_t height)
{
    const float *angle = s->texel + 3 * (size_t)s->cells;
    sfield__gathered *g = (sfield__gathered *)sfield__alloc_array(&s->allocator, s->cells, sizeof *g);
    uint32_t i, k;
    if (!g) return 0;
    memset(g, 0, s->cells * sizeof *g);
    sfield__gather_map(s, rgb, width, height, g);
    for (k = 0; k < 3; k++) {
        float *sky = s->sky + (size_t)k * s->cells;
        double all = 0, sum = 0;
        for (i = 0; i < s->cells; i++) {
            const double least = (double)g[i].least[k], more = g[i].rgb[k] - least * g[i].angle;
            sky[i] = (float)(least + more / (double)angle[i]);
            all += g[i].rgb[k];
            sum += (double)sky[i] * (double)angle[i];
        }
        for (i = 0; i < s->cells && sum > 0; i++) sky[i] = (float)((double)sky[i] * (all / sum));
    }
    sfield__free(&s->allocator, g);
    return 1;
}

static void sfield__turn_harmonics(sfield_scene *s)
{
    sfield_rotation r;
    float tile[SFIELD_MAX_COEFS * SFIELD__LANES] = { 0 };
    uint32_t c, k;
    for (c = 0; c < 3; c++) {
        float *now = s->sky_now + c * s->planes;
        memcpy(now, s->sky_still + c * s->planes, s->coefs * sizeof *now);
        if (sfield_sh_rotation(s->algebra, s->sky_turn, &r) == SFIELD_OK) {
            sfield__load_tile(s->coefs, 1, now, 1, tile);
            sfield__rotate16(&r, tile, tile, SFIELD__LANES, 0, s->simd);
            sfield__store_tile(s->coefs, 1, tile, now, 1);
        }
        for (k = 0; k < s->coefs; k++) now[k] += s->sun[c * s->planes + k];
    }
}

/* Turns the sky into the world. Harmonics turn their coefficients; wavelets resample the cube map, once. */
static void sfield__turn_sky(sfield_scene *s)
{
    if (s->algebra) sfield__turn_harmonics(s);
#ifndef SFIELD_WITHOUT_WAVELETS
    else sfield__turn_cube(s);
#endif
    s->sky_hash = sfield__hash_bytes(1, s->sky_now, 3 * (size_t)s->planes);
    sfield__note_change(s, 0);
}

static int sfield__rotation_good(const float *m)
{
    float scale;
    return !m || sfield__m4_is_rigid_uniform(sfield__m4_or_identity(m), &scale);
}

static void sfield__set_turn(sfield_scene *s, const float *to_world)
{
    static const float zeros[16] = { 0 };
    const float *m = sfield__m4_or_identity(to_world ? to_world : zeros);
    uint32_t i;
    float scale = 1;                /* sfield__rotation_good has said that m is rigid */
    (void)sfield__m4_is_rigid_uniform(m, &scale);
    memset(s->sky_turn, 0, sizeof s->sky_turn);
    for (i = 0; i < 12; i++) s->sky_turn[i] = i % 4 == 3 ? 0 : m[i] / scale;
    s->sky_turn[15] = 1;
    sfield__turn_sky(s);
}

SFIELD_DEF sfield_result sfield_scene_environment(sfield_scene *s, const float *rgb, uint32_t width,
                                                  uint32_t height, const float to_world[16])
{
    uint32_t c;
    sfield__logger log;
    if (!s) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&s->desc.system, "sfield_scene_environment");
    if (!sfield__rotation_good(to_world))
        return sfield__fail(&log, SFIELD_ERR_INPUT, "to_world", "is no rotation");
    if (rgb && (!sfield__check_value(&log, width >= 1 && width <= 65536, "width", width, "1..65536") ||
                !sfield__check_value(&log, height >= 1 && height <= 65536, "height", height, "1..65536")))
        return SFIELD_ERR_ARGUMENT;
    if (rgb && !sfield__take_map(s, rgb, width, height)) return SFIELD_ERR_ALLOC;
    if (!rgb) memset(s->sky, 0, 3 * (size_t)s->cells * sizeof *s->sky);
    memset(s->sun, 0, 3 * (size_t)s->planes * sizeof *s->sun);
    s->has_sky = rgb != NULL;
    s->has_sun = 0;
    for (c = 0; c < 3 && s->algebra; c++)
        (void)sfield_sh_project(s->desc.bands, s->side, s->sky + c * s->cells, 1,
                                s->sky_still + c * s->planes);
    sfield__set_turn(s, to_world);
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_scene_turn(sfield_scene *s, const float to_world[16])
{
    sfield__logger log;
    if (!s) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&s->desc.system, "sfield_scene_turn");
    if (!to_world) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "to_world", "is NULL");
    if (!sfield__rotation_good(to_world))
        return sfield__fail(&log, SFIELD_ERR_INPUT, "to_world", "is no rotation");
    sfield__set_turn(s, to_world);
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_scene_sun(sfield_scene *s, const float direction[3],
                                          const float irradiance[3])
{
    double d[3], y[SFIELD_MAX_COEFS];
    uint32_t c, k;
    sfield__logger log;
    if (!s) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&s->desc.system, "sfield_scene_sun");
    if (direction && !irradiance) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "irradiance", "is NULL");
    if (!direction) {
        memset(s->sun, 0, 3 * (size_t)s->planes * sizeof *s->sun);
        s->has_sun = 0;
        sfield__turn_sky(s);
        return SFIELD_OK;
    }
    for (k = 0; k < 3; k++) d[k] = (double)direction[k];
    if (sfield__unit_vector(direction) != 1) {
        sfield__log_value(&log, "the length of direction", sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]),
                          "1 (0.97..1.03)");
        return SFIELD_ERR_INPUT;
    }
    for (k = 0; k < 3; k++)
        if (!sfield__in(irradiance[k], 0, 1e18f)) {
            sfield__log_element(&log, "irradiance", k, "is", (double)irradiance[k], "0..1e18");
            return SFIELD_ERR_INPUT;
        }
    if (s->algebra) {
        sfield_sh_basis(s->desc.bands, d, y);
        for (c = 0; c < 3; c++)
            for (k = 0; k < s->coefs; k++) s->sun[c * s->planes + k] += irradiance[c] * (float)y[k];
    } else {
        uint32_t at = sfield_cube_find(s->side, direction);
        for (c = 0; c < 3; c++) s->sun[c * s->cells + at] += irradiance[c] / s->texel[3 * s->cells + at];
    }
    if (!s->has_sky && !s->has_sun) sfield__set_turn(s, NULL);
    else sfield__turn_sky(s);
    s->has_sun = 1;
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_scene_sky(const sfield_scene *s, float *coefs)
{
    sfield__logger log;
    uint32_t c, n;
    if (!s) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&s->desc.system, "sfield_scene_sky");
    if (!coefs) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "coefs", "is NULL");
    n = s->algebra ? s->coefs : s->cells;
    for (c = 0; c < 3; c++) memcpy(coefs + c * n, s->sky_now + c * s->planes, n * sizeof *coefs);
    return SFIELD_OK;
}

/* ==== src/shadowfield/shade_cache.h ==== */

/* ---- shading: lazy occlusion updating ---- */

/* Returns how many floats a cache keeps of the results of a point. */
static uint32_t sfield__results_of(const sfield_cache *c) { return c->chains > 1 ? 10 : 4; }

/* Makes room for so many T of each point and light, and forgets all that was kept. Without memory the cache
   stays as it was. */
static sfield_result sfield__lay_cache(sfield_cache *c, uint32_t chains)
{
    const size_t own = c->cells ? c->points : (c->points + 15) / 16, skies = c->cells ? own * chains : 0;
    sfield_cache n = *c;
    size_t units, hashes, lanes;
    size_t values, bytes;
    uint8_t *at;
    if (!sfield__mul_size(own, (size_t)c->lights * chains, &units) || units > SIZE_MAX / 16384)
        return SFIELD_ERR_ALLOC;
    n.chains = chains;
    hashes = c->cells ? units : units / chains;
    lanes = units * (c->cells ? 1 : 32);            /* marks as many as lights */
    values = lanes * (c->cells ? (uint32_t)SFIELD__CACHED : c->coefs);
    bytes = (hashes + (c->cells ? skies : own)) * sizeof *n.hash + own * sizeof *n.last +
            sfield__results_of(&n) * c->points * sizeof *n.result + lanes * sizeof *n.scale +
            (c->cells ? 4 * values + 3 * skies * sizeof *n.sky : 2 * values + own);
    at = (uint8_t *)sfield__alloc(&c->allocator, bytes);
    if (!at) return SFIELD_ERR_ALLOC;
    n.bytes = sizeof n + bytes;
    n.hash = (uint64_t *)(void *)at;
    n.lit = n.hash + hashes;
    n.last = (sfield__last *)(void *)(n.lit + (c->cells ? skies : own));
    n.result = (float *)(void *)(n.last + own);
    n.scale = n.result + sfield__results_of(&n) * c->points;
    n.sky = n.scale + lanes;
    n.value = (int16_t *)(void *)(n.sky + 3 * skies);
    n.index = c->cells ? (uint16_t *)(n.value + values) : NULL;
    n.marks = (uint8_t *)(n.value + values);
    memset(n.hash, 0, (size_t)((uint8_t *)n.result - at));
    sfield__free(&c->allocator, c->hash);
    *c = n;
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_cache_create(const sfield_scene *s, size_t point_count, uint32_t light_count,
                                             sfield_cache **out)
{
    sfield__logger log;
    sfield_cache *c;
    if (!s) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&s->desc.system, "sfield_cache_create");
    if (!out) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "out", "is NULL");
    if (!sfield__check_value(&log, point_count && point_count <= 0x7fffffffu, "point_count",
                             (double)point_count, "1..2^31 - 1") ||
        !sfield__check_value(&log, light_count && light_count <= 65536, "light_count", light_count,
                             "1..65536"))
        return SFIELD_ERR_ARGUMENT;
    c = (sfield_cache *)sfield__alloc(&s->allocator, sizeof *c);
    if (!c) return SFIELD_ERR_ALLOC;
    memset(c, 0, sizeof *c);
    c->allocator = s->allocator;
    c->points = point_count;
    c->lights = light_count;
    c->coefs = s->coefs;
    c->cells = s->algebra ? 0 : s->cells;
    if (sfield__lay_cache(c, 1) != SFIELD_OK) {
        sfield_cache_free(c);
        return SFIELD_ERR_ALLOC;
    }
    *out = c;
    return SFIELD_OK;
}

SFIELD_DEF void sfield_cache_free(sfield_cache *cache)
{
    sfield__allocator a;
    if (!cache) return;
    a = cache->allocator;
    sfield__free(&a, cache->hash);
    sfield__free(&a, cache);
}

SFIELD_DEF size_t sfield_cache_bytes(const sfield_cache *cache) { return cache ? cache->bytes : 0; }

/* The least T that the cache keeps; a smaller one becomes 0, since 32767 divided by it might be beyond
   floats. */
#define SFIELD__LEAST_T 1e-30f

/* Hashes all that T of a set depends on besides the occluders before each light and, with gloss, the BRDFs:
   how the scene computes, and where the points are. Points that lie on an entity move with it. The number of
   occluders decides where T is rounded between lights (sfield__chain_products). */
static uint64_t sfield__hash_set(const sfield_scene *s, const sfield_points *set)
{
    const uint32_t how[5] = { (uint32_t)s->desc.product, s->coefs, s->occluder_count, set->entity,
                              s->has_sky || s->has_sun };
    uint64_t h = sfield__hash_bytes((uint64_t)(uintptr_t)s, how, 5);
    h = sfield__hash_bytes(h, &s->desc.reach, 1);
    h = sfield__hash(h, (uint64_t)(uintptr_t)set->self);
    if (set->self) h = sfield__hash(h, set->self->h.crc);
    if (set->entity) h = sfield__hash_bytes(h, s->item[set->entity - 1].e.transform, 16);
    return h;
}

/* Returns q rounded to 16 bits. What is not in their range, as where T is no number, becomes 0. */
static int16_t sfield__to_int16(float q)
{
    if (!(fabsf(q) < 32767.5f)) return 0;
    return (int16_t)(q + (q < 0 ? -0.5f : 0.5f));
}

/* Returns the scale of values whose largest is `most`: 0 if that is beyond floats. */
static float sfield__scale_of(float most) { return sfield__finite(most) ? most / 32767 : 0; }

/* Keeps all T of a tile in a slot. */
static void sfield__keep_tile(sfield_cache *c, size_t slot, const float *t, uint32_t chains)
{
    float *scale = c->scale + slot * c->chains * SFIELD__LANES;
    int16_t *value = c->value + slot * c->chains * c->coefs * SFIELD__LANES;
    uint32_t k, l;
    for (; chains > 0; chains--) {
        for (l = 0; l < SFIELD__LANES; l++) {
            float most = 0, inverse;
            for (k = 0; k < c->coefs; k++) {
                float x = fabsf(t[k * SFIELD__LANES + l]);
                most = x > most ? x : most;
            }
            scale[l] = sfield__scale_of(most);
            inverse = most > SFIELD__LEAST_T ? 32767 / most : 0;
            for (k = 0; k < c->coefs; k++)
                value[k * SFIELD__LANES + l] = sfield__to_int16(t[k * SFIELD__LANES + l] * inverse);
        }
        scale += SFIELD__LANES;
        value += c->coefs * SFIELD__LANES;
        t += c->coefs * SFIELD__LANES;
    }
}

static void sfield__recall_tile(const sfield_cache *c, size_t slot, float *t, uint32_t chains, int simd)
{
    const int16_t *value = c->value + slot * c->chains * c->coefs * SFIELD__LANES;
    const float *scale = c->scale + slot * c->chains * SFIELD__LANES;
    for (; chains > 0; chains--) {
        sfield__recall16(value, scale, c->coefs, t, simd);
        scale += SFIELD__LANES;
        value += c->coefs * SFIELD__LANES;
        t += c->coefs * SFIELD__LANES;
    }
}

/* Returns the slot of T after `number` of the steps that all lights share. These slots come after those of
   lights. */
static size_t sfield__mark_slot(const sfield_cache *c, size_t tile, uint32_t number)
{
    return ((c->points + 15) / 16 + tile) * c->lights + number - 1;
}

/* ---- results of the last frame ---- */

enum { SFIELD__HAS_RGB = 1, SFIELD__HAS_AMBIENT = 2, SFIELD__HAS_GLOSS = 4, SFIELD__HAS_GRAZING = 8 };

/* Returns the results that a set asks for, as bits. */
static int sfield__wanted_of(const sfield_points *set)
{
    return (set->rgb ? SFIELD__HAS_RGB : 0) | (set->ambient ? SFIELD__HAS_AMBIENT : 0) |
           (set->gloss ? SFIELD__HAS_GLOSS : 0) | (set->gloss && set->grazing ? SFIELD__HAS_GRAZING : 0);
}

/* Returns the bits of the points that are in view, as the caller says. */
static uint32_t sfield__bits_in_view(const sfield_points *set, size_t first, uint32_t count)
{
    uint32_t l, bits = 0;
    for (l = 0; l < count; l++) bits |= (uint32_t)(!set->in_view || set->in_view[first + l]) << l;
    return bits;
}

/* Returns whether an occluder that stood or stands at c may hide something of the sphere about some points.
   The test is wider than the one that leaves occluders out, by as much as roundings can matter. */
static int sfield__may_hide(const sfield__last *last, const float *c, float reach)
{
    float x = c[0] - last->middle[0], y = c[1] - last->middle[1], z = c[2] - last->middle[2];
    return sqrtf(x * x + y * y + z * z) - last->extent < 1.0001f * reach;
}

/* Returns whether the results of a unit (a tile or a point) in the last frame still hold. They do if nothing
   changed but occluders that were, and are, out of its reach, and if the same points are in view: which of
   these share samples of a field decides the last bits. The test costs a few comparisons for each occluder
   that moved. */
static int sfield__is_untouched(const sfield_scene *s, const sfield_points *set, uint64_t set_hash,
                                size_t unit, uint32_t in_view)
{
    sfield__last *last = &set->cache->last[unit];
    uint32_t i;
    if (!last->seen || ((in_view ^ last->in_view) & last->active) || (sfield__wanted_of(set) & ~last->has))
        return 0;
    if (last->seen == sfield__hash(set_hash, s->now_hash)) return 1;
    if (!s->before_hash || last->seen != sfield__hash(set_hash, s->before_hash)) return 0;
    for (i = 0; i < s->moved_count; i++) {
        const sfield__item *it = &s->item[s->moved[i]];
        if (sfield__may_hide(last, it->was, it->reach) || sfield__may_hide(last, it->center[0], it->reach))
            return 0;
    }
    last->seen = sfield__hash(set_hash, s->now_hash);
    return 1;
}

/* Writes the results of the last frame again, 0 for points that are not in view. Returns how many are. */
static uint32_t sfield__repeat_results(const sfield_points *set, size_t unit, size_t first, uint32_t count,
                                       uint32_t in_view)
{
    const uint32_t results = sfield__results_of(set->cache);
    const float *result = set->cache->result + results * first;
    uint32_t l, k;
    in_view &= set->cache->last[unit].active;
    for (l = 0; l < count; l++, result += results) {
        const int here = in_view >> l & 1, glossy = here && results > 4;
        const size_t at = 3 * (first + l);
        for (k = 0; k < 3 && set->rgb; k++) set->rgb[at + k] = here ? result[k] : 0.0f;
        if (set->ambient) set->ambient[first + l] = here ? result[3] : 0.0f;
        for (k = 0; k < 3 && set->gloss; k++) set->gloss[at + k] = glossy ? result[4 + k] : 0.0f;
        for (k = 0; k < 3 && set->gloss && set->grazing; k++)
            set->grazing[at + k] = glossy ? result[7 + k] : 0.0f;
    }
    return sfield__popcount(in_view);
}

/* Keeps the results that were just written for a unit of points. */
static void sfield__keep_results(const sfield_points *set, size_t unit, size_t first, uint32_t count,
                                 const sfield__last *now)
{
    const uint32_t results = sfield__results_of(set->cache);
    sfield__last *last = &set->cache->last[unit];
    float *result = set->cache->result + results * first;
    uint32_t l, k;
    *last = *now;
    last->has = sfield__wanted_of(set);
    for (l = 0; l < count; l++, result += results) {
        const size_t at = 3 * (first + l);
        for (k = 0; k < 3; k++) result[k] = set->rgb ? set->rgb[at + k] : 0.0f;
        result[3] = set->ambient ? set->ambient[first + l] : 0.0f;
        for (k = 0; k < 3 && results > 4; k++) {
            result[4 + k] = set->gloss ? set->gloss[at + k] : 0.0f;
            result[7 + k] = set->gloss && set->grazing ? set->grazing[at + k] : 0.0f;
        }
    }
}

/* ==== src/shadowfield/shade_tile.h ==== */

/* ---- shading: a tile of sixteen points ---- */

/* What is known of an occluder of a tile: its visibility was not fetched yet; it was; or it need not be. */
enum { SFIELD__NOT_FETCHED, SFIELD__FETCHED, SFIELD__ALL_HIDDEN };

typedef struct sfield__tile {
    const sfield_scene *s;
    const sfield_points *set;
    size_t    first;                            /* number of the first point */
    uint32_t  lanes;                            /* how many points there are */
    uint32_t  active, in_view;                  /* bits: points that can be shaded; those of them that the
                                                   caller sees */
    float     p[48], n[48], view[48];           /* planes, world */
    float     middle[3], extent;                /* a sphere about all lanes */
    uint32_t  count;                            /* occluders that count for some lane: `item` of each, and
                                                   `order` from near to far */
    uint32_t *item, *order;
    uint32_t *used, *shown;                     /* bits: lanes for which an occluder counts; those of them
                                                   for which no nearer one hides it */
    float    *mean, *widest, *farthest;         /* the middle's distance; the greatest sine of the inscribed
                                                   sphere, and the greatest distance, of all lanes */
    float    *d2, *factor, *occlusion;          /* of each occluder: 16, 16 and 16 n^2 floats */
    uint8_t  *state;                            /* of each occluder: SFIELD__NOT_FETCHED, ... */
    uint32_t  lights;                           /* the environment, if there is one, comes after them */
    int       sky;                              /* 1: there is an environment */
    int       chains;                           /* how many T a point has: 1, with gloss 2 or 3 */
    int       all_round;                        /* not 0: occluders below the horizon count too */
    uint16_t *mask;                             /* [light][occluder in order]: lanes for which it is nearer */
    uint64_t  set_hash;                         /* sfield__hash_set, and sfield__hash_brdfs */
    uint64_t *hash, occluders_hash;             /* with a cache: what T of each light depends on, and T behind
                                                   all occluders */
    uint8_t  *needed;                           /* of each light: not 0 if its T has to be computed */
    uint32_t *prefix;                           /* of each light: how many occluders, from the first in order
                                                   on, are nearer than the light for all lanes that they count
                                                   for */
    float    *t;                                /* [light][chain] 16 n^2 */
    float    *start;                            /* [chain] 16 n^2 */
    float    *rows, *planes, *turned;           /* for one entity: 16 rows of 3 channels; planes twice */
    sfield_scene_stats stats;
} sfield__tile;

/* Divides memory among the arrays of one task; with NULL only measures how much they need. 65,535 entities
   need up to 2^34 bytes, which a size_t may not hold. */
static uint64_t sfield__carve_tile(sfield__tile *t, uint8_t *memory, uint32_t occluders, uint32_t lights,
                              uint32_t coefs, uint32_t chains)
{
    uint64_t at = 0, c = coefs * SFIELD__LANES, n = occluders ? occluders : 1, slots = (uint64_t)lights + 1;
#define SFIELD__CARVE(member, type, number)                                \
    do {                                                                   \
        if (memory) t->member = (type *)(void *)(memory + (size_t)at);     \
        at += ((number) * sizeof(type) + 63) / 64 * 64;                    \
    } while (0)
    SFIELD__CARVE(occlusion, float, n * c);
    SFIELD__CARVE(t, float, (slots * chains > 6 ? slots * chains : 6) * c);  /* all, a light's */
    SFIELD__CARVE(start, float, chains * c);
    /* coefficients of a row: a multiple of 8 */
    SFIELD__CARVE(rows, float, 3 * (c + 7 * SFIELD__LANES) + 8);
    SFIELD__CARVE(planes, float, c + 7 * SFIELD__LANES);
    SFIELD__CARVE(turned, float, c);
    SFIELD__CARVE(d2, float, n * SFIELD__LANES);
    SFIELD__CARVE(factor, float, n * SFIELD__LANES);
    SFIELD__CARVE(mean, float, n);
    SFIELD__CARVE(widest, float, n);
    SFIELD__CARVE(farthest, float, n);
    SFIELD__CARVE(prefix, uint32_t, slots);
    SFIELD__CARVE(item, uint32_t, n);
    SFIELD__CARVE(order, uint32_t, n);
    SFIELD__CARVE(used, uint32_t, n);
    SFIELD__CARVE(shown, uint32_t, n);
    SFIELD__CARVE(hash, uint64_t, slots);
    SFIELD__CARVE(mask, uint16_t, slots * n);
    SFIELD__CARVE(state, uint8_t, n);
    SFIELD__CARVE(needed, uint8_t, slots);
#undef SFIELD__CARVE
    return at;
}

#ifndef SFIELD_WITHOUT_GLOSS
/* Returns how many T a point of a set has: one for rgb, with gloss a second for the lobe, or two more for the
   metal-rough BRDF. */
static int sfield__count_chains(const sfield_points *set)
{
    return !set->gloss ? 1 : set->materials ? 3 : set->exponents ? 2 : 1;
}
#endif

static void sfield__load_lanes(sfield__tile *t)
{
    const sfield_points *set = t->set;
    const float *m = !set->entity ? NULL : t->s->item[set->entity - 1].e.transform;
    const float *turn = m ? t->s->item[set->entity - 1].turn : NULL;
    uint32_t l, k;
    t->active = t->in_view = 0;
    for (l = 0; l < SFIELD__LANES; l++) {
        size_t i = t->first + (l < t->lanes ? l : 0);
        sfield__v3 p = sfield__v3_load(sfield__row(set->positions, set->position_stride, i));
        sfield__v3 n = sfield__v3_load(sfield__row(set->normals, set->normal_stride, i)), v = n;
        if (m) {
            p = sfield__m4_point(m, p);
            n = sfield__v3_make(turn[0] * n.x + turn[3] * n.y + turn[6] * n.z,
                                turn[1] * n.x + turn[4] * n.y + turn[7] * n.z,
                                turn[2] * n.x + turn[5] * n.y + turn[8] * n.z);
        }
        if (t->chains > 1)
            v = sfield__v3_load(sfield__row(set->to_eye, set->to_eye_stride, i));
        if (l < t->lanes && sfield__finite(sfield__v3_dot(p, p)) && sfield__v3_dot(n, n) < 1.1f &&
            sfield__v3_dot(v, v) < 1.1f && sfield__v3_dot(n, n) > 0.9f && sfield__v3_dot(v, v) > 0.9f) {
            t->active |= 1u << l;
            if (!set->in_view || set->in_view[i]) t->in_view |= 1u << l;
        } else {
            p = sfield__v3_make(0, 0, 0);
            n = v = sfield__v3_make(0, 1, 0);
        }
        for (k = 0; k < 3; k++) {
            t->p[16 * k + l] = k == 0 ? p.x : k == 1 ? p.y : p.z;
            t->n[16 * k + l] = k == 0 ? n.x : k == 1 ? n.y : n.z;
            t->view[16 * k + l] = k == 0 ? v.x : k == 1 ? v.y : v.z;
        }
    }
}

/* Finds a sphere about the lanes that can be shaded, from the middle of their box. */
static void sfield__bound_lanes(sfield__tile *t)
{
    float most = 0;
    uint32_t k, l;
    for (k = 0; k < 3; k++) {
        float low = 3e38f, high = -3e38f;
        for (l = 0; l < SFIELD__LANES; l++) {
            float x = t->p[16 * k + l];
            if (!(t->active >> l & 1)) continue;
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        t->middle[k] = t->active ? 0.5f * low + 0.5f * high : 0;
        most += t->active ? (high - low) * (high - low) : 0;
    }
    t->extent = 0.5f * sqrtf(most);
}

static void sfield__measure_distances(const float *p, const float *c, float *d2)
{
    int l;
    for (l = 0; l < SFIELD__LANES; l++) {
        float x = c[0] - p[l], y = c[1] - p[16 + l], z = c[2] - p[32 + l];
        d2[l] = x * x + y * y + z * z;
    }
}

/* Computes where the lanes are in a field of an entity: planes, about its center, in r. */
static void sfield__move_to_local(const sfield__item *it, int which, const float *p, float *local, int simd)
{
    sfield__to_local16(it->turn, it->center[which], it->inverse[which], p, local, simd);
}

/* Returns whether light j is the entity that the points lie on. All of its light comes from below their
   horizon, or is hidden by their self-visibility: only ringing would be added, of the strongest light. */
static int sfield__is_own(const sfield__tile *t, uint32_t j)
{
    return j < t->lights && t->s->light[j] + 1 == t->set->entity;
}

/* Returns how many lights a set has, the environment among them, but not the entity that the set lies on. */
static uint32_t sfield__lights_of(const sfield_scene *s, const sfield_points *set, int sky)
{
    return s->light_count + (uint32_t)sky - (set->entity && s->item[set->entity - 1].e.source ? 1u : 0u);
}

/* ==== src/shadowfield/rooms.h ==== */

/* ---- scenes: lights inside of what hides ---- */

/* A field says in which directions its object hides, but not how far away. Where the object is a room, it
   hides all that lies beyond its walls, and nothing of a light between them. A light from whose middle more
   than half of all directions are hidden lies in the convex hull of the object, since what lies on one side
   of a plane hides no more than half. The object then is a room for this light, taken for convex: from points
   that lie in the hull as well it does not hide the light; from all others it comes before the light,
   whichever centre is nearer. */

/* Returns the share of directions that an occluder hides from lane l of a place. Of logarithms that is
   unknown: 0, so that there are no rooms. */
static float sfield__share_at(const sfield__item *it, const sfield__place *at, uint32_t l, int simd)
{
    const sfield_field *f = it->e.occlusion;
    float first[16];
    if (f->h.logarithm) return 0;
#ifndef SFIELD_WITHOUT_WAVELETS
    if (f->h.basis == SFIELD_BASIS_HAAR) return sfield__hidden_share(f, at, (int)l);
#endif
    sfield__fetch_lane(f, at, (int)l, 0, 8, first, simd);
    return first[0] * sfield__y00;
}

/* Returns which lanes lie in an occluder's hull, of some whose places are p, in planes, and d2 the squares of
   their distances from its centre. */
static uint32_t sfield__find_inside(const sfield__item *it, const float *p, const float *d2, uint32_t lanes,
                                    int simd)
{
    float local[48];
    sfield__place at;
    uint32_t l, near_by = 0, inside = 0;
    for (l = 0; l < SFIELD__LANES; l++)
        if (lanes >> l & 1 && d2[l] < it->radius[0] * it->radius[0]) near_by |= 1u << l;
    if (!near_by) return 0;
    sfield__move_to_local(it, 0, p, local, simd);
    sfield__locate16(it->e.occlusion, local, &at, simd);
    for (l = 0; l < SFIELD__LANES; l++)
        if (near_by >> l & 1 && sfield__share_at(it, &at, l, simd) > 0.5f) inside |= 1u << l;
    return inside;
}

static int sfield__is_in_hull(const sfield__item *it, const float *x, int simd)
{
    float p[48] = { 0 }, d2[SFIELD__LANES] = { 0 };
    uint32_t k;
    for (k = 0; k < 3; k++) {
        p[16 * k] = x[k];
        d2[0] += (x[k] - it->center[0][k]) * (x[k] - it->center[0][k]);
    }
    return sfield__find_inside(it, p, d2, 1, simd) != 0;
}

/* Lists the lights that lie in the hull of another entity. Returns 0 without memory. A heap of thousands of
   lights and bodies would take gigabytes and minutes, and is no room. */
static int sfield__find_rooms(sfield_scene *s)
{
    uint32_t i, j;
    if (s->overlaps > 65536) return 1;
    s->held = (struct sfield__tenant *)sfield__alloc_array(&s->allocator, s->overlaps, sizeof *s->held);
    if (!s->held) return 0;
    for (i = 0; i < s->light_count; i++)
        for (j = 0; j < s->occluder_count; j++) {
            const uint32_t item = s->occluder[j];
            sfield__item *it = &s->item[item];
            if (s->light[i] == item || s->held_count == s->overlaps) continue;
            if (!sfield__is_in_hull(it, s->item[s->light[i]].center[1], s->simd)) continue;
            s->held[s->held_count].light = i;
            s->held[s->held_count++].item = item;
            if (it->holds) continue;
            it->holds = 1;
            it->inscribed = 0;          /* its middle, which nobody sees from outside, hides nothing inside */
            it->body = sfield__hash(it->body, 1) | 1;
        }
    return 1;
}

/* Returns whether light j lies in the hull of an entity. The list rises with the light, then the entity. */
static int sfield__is_held(const sfield_scene *s, uint32_t j, uint32_t item)
{
    uint32_t low = 0, high = s->held_count;
    if (!s->item[item].holds || j == s->light_count) return 0;
    while (low < high) {
        const uint32_t middle = (low + high) / 2;
        const struct sfield__tenant *held = &s->held[middle];
        if (held->light < j || (held->light == j && held->item < item)) low = middle + 1;
        else high = middle;
    }
    return low < s->held_count && s->held[low].light == j && s->held[low].item == item;
}

/* Returns whether points lie on the room in which light j is: their self-visibility, which says that the room
   is all around, does not count for the light. Nobody asks on which side of a wall they lie: points on the
   outside that face the light get it through the wall. */
static int sfield__is_home(const sfield_scene *s, const sfield_points *set, uint32_t j)
{
    return set->entity && set->self && sfield__is_held(s, j, set->entity - 1);
}

/* Returns the lanes from which candidate o hides light j that lies in it. */
static uint32_t sfield__mask_room(const sfield__tile *t, uint32_t o)
{
    const float *d2 = t->d2 + (size_t)o * SFIELD__LANES;
    return t->used[o] & ~sfield__find_inside(&t->s->item[t->item[o]], t->p, d2, t->used[o], t->s->simd);
}

static void sfield__start_tile(sfield__tile *t);
static void sfield__fetch_occluder(sfield__tile *t, uint32_t i);
static void sfield__apply_occluder(sfield__tile *t, uint32_t i, uint32_t mask, float *chain);

/* Computes T of a light in the room that the points lie on, from the first of `count` occluders on. */
static void sfield__chain_at_home(sfield__tile *t, const uint16_t *mask, uint32_t count, float *light)
{
    const sfield_points *set = t->set;
    sfield_points bare = *set;
    float *start = t->start;
    uint32_t i;
    bare.self = NULL;
    t->set = &bare;
    t->start = light;
    sfield__start_tile(t);
    t->set = set;
    t->start = start;
    for (i = 0; i < count; i++) {
        sfield__fetch_occluder(t, t->order[i]);
        sfield__apply_occluder(t, t->order[i], mask[i], light);
    }
}

/* ==== src/shadowfield/shade_culling.h ==== */

/* ---- shading: which occluders count for which points ---- */

/* Returns 1 if the points of a set lie on an entity that hides, else 0. */
static uint32_t sfield__is_on_occluder(const sfield_scene *s, const sfield_points *set)
{
    return set->entity && s->item[set->entity - 1].e.occlusion ? 1u : 0u;
}

/* Returns whether candidate a lies behind candidate b; equal ones keep the order of the scene. */
static int sfield__is_after(const sfield__tile *t, uint32_t a, uint32_t b)
{
    return t->mean[a] > t->mean[b] || (!(t->mean[a] < t->mean[b]) && t->item[a] > t->item[b]);
}

/* Puts an occluder among the candidates, from near to far by the middle of the tile, if it counts for any
   lane: in reach (section 4.2, third rule) and, but for incident radiance, not below the horizon (first). */
static void sfield__try_candidate(sfield__tile *t, uint32_t item)
{
    const sfield__item *it = &t->s->item[item];
    const float *c = it->center[0], x = c[0] - t->middle[0], y = c[1] - t->middle[1], z = c[2] - t->middle[2];
    const float mean = sqrtf(x * x + y * y + z * z), least = mean - t->extent;
    uint32_t j, near_by, used;
    if (item + 1 == t->set->entity || !(least < it->reach)) return;
    used = sfield__look_at16(t->p, t->n, c, it->reach * it->reach, -it->radius[0],
                             t->d2 + (size_t)t->count * SFIELD__LANES, t->s->simd);
    near_by = used & t->active;
    used = t->all_round ? near_by : near_by & used >> 16;
    t->stats.culled_far -= sfield__popcount(near_by);
    t->stats.culled_horizon += sfield__popcount(near_by & ~used);
    if (!used) return;
    t->farthest[t->count] = mean + t->extent;
    t->widest[t->count] = least > it->inscribed ? it->inscribed / least : 1;
    t->used[t->count] = used;
    t->item[t->count] = item;
    t->mean[t->count] = mean;
    t->state[t->count] = SFIELD__NOT_FETCHED;
    for (j = t->count; j > 0 && sfield__is_after(t, t->order[j - 1], t->count); j--)
        t->order[j] = t->order[j - 1];
    t->order[j] = t->count++;
}

/* Finds the occluders that count for any lane. All are far until they prove to be near. */
static void sfield__find_candidates(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    const uint32_t others = s->occluder_count - sfield__is_on_occluder(s, t->set);
    uint32_t i;
#ifndef SFIELD_WITHOUT_HIERARCHY
    sfield__walk w;
#endif
    t->count = 0;
    sfield__bound_lanes(t);
    t->stats.pairs += (uint64_t)t->lanes * others;
    t->stats.culled_far += (uint64_t)sfield__popcount(t->active) * others;
#ifdef SFIELD_WITHOUT_HIERARCHY
    for (i = 0; i < s->occluder_count; i++) sfield__try_candidate(t, s->occluder[i]);
#else
    sfield__start_walk(&w, s, t->middle, t->extent);
    while ((i = sfield__next_near(&w)) != SFIELD__NONE) sfield__try_candidate(t, i);
#endif
}

/* Computes what is left of each candidate for each lane. */
static void sfield__fade_candidates(sfield__tile *t)
{
    uint32_t i;
    for (i = 0; i < t->count; i++) {
        const size_t at = (size_t)i * SFIELD__LANES;
        const float reach = t->s->item[t->item[i]].reach;
        sfield__fade16(t->d2 + at, t->farthest[i] > 0.75f * reach ? 1 / reach : 0, t->used[i], t->factor + at,
                       t->s->simd);
    }
}

#ifndef SFIELD_WITHOUT_HIERARCHY
/* Returns whether light j lies behind all candidates as each lane sees them, by more than what roundings come
   to. The environment does. */
static int sfield__is_behind(const sfield__tile *t, uint32_t j, float farthest)
{
    const float *m = t->middle, slack = 1e-6f * (fabsf(m[0]) + fabsf(m[1]) + fabsf(m[2])) + 1e-18f;
    const sfield__item *it;
    float d;
    if (j == t->lights) return 1;
    it = &t->s->item[t->s->light[j]];
    d = sfield__v3_length(sfield__v3_sub(sfield__v3_load(it->center[1]), sfield__v3_load(m)));
    return !it->e.occlusion && d < 1e18f && 0.9999f * d > farthest + 2 * (t->extent + slack);
}
#endif

/* Finds, for each light, the lanes for which each occluder counts and is nearer than the light. */
static void sfield__find_masks(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    const int cached = t->set->cache != NULL;
    float light[SFIELD__LANES];
    uint32_t j, i;
#ifndef SFIELD_WITHOUT_HIERARCHY
    float farthest = 0;
    for (i = 0; i < t->count; i++) farthest = t->farthest[i] > farthest ? t->farthest[i] : farthest;
#endif
    t->occluders_hash = t->set_hash;
    for (i = 0; i < t->count && cached; i++) {
        const uint32_t o = t->order[i];
        t->occluders_hash = sfield__hash(t->occluders_hash, s->item[t->item[o]].body);
        t->occluders_hash = sfield__hash(t->occluders_hash, t->used[o]);
    }
    t->occluders_hash |= 1;
    for (j = 0; j < t->lights + (uint32_t)t->sky; j++) {
        uint16_t *mask = t->mask + (size_t)j * (s->occluder_count ? s->occluder_count : 1);
        const uint32_t own = j < t->lights ? s->light[j] : SFIELD__NONE;
#ifdef SFIELD_WITHOUT_HIERARCHY
        const int behind = j == t->lights;
#else
        const int behind = sfield__is_behind(t, j, farthest);
#endif
        uint32_t prefix = 0;
        if (sfield__is_own(t, j)) continue;
        if (!behind) sfield__measure_distances(t->p, s->item[own].center[1], light);
        t->hash[j] = t->set_hash;
        for (i = 0; i < t->count; i++) {
            const uint32_t o = t->order[i], used = t->used[o];
            uint32_t bits = used;
            if (!behind)
                bits = t->item[o] == own
                           ? 0
                           : used & sfield__nearer16(t->d2 + (size_t)o * SFIELD__LANES, light, s->simd);
#ifndef SFIELD_WITHOUT_ROOMS
            if (sfield__is_held(s, j, t->item[o])) bits = sfield__mask_room(t, o);
#endif
            mask[i] = (uint16_t)bits;
            prefix += prefix == i && bits == used;
            if (bits && cached)
                t->hash[j] = sfield__hash(sfield__hash(t->hash[j], s->item[t->item[o]].body), bits);
        }
#ifndef SFIELD_WITHOUT_ROOMS
        if (sfield__is_home(s, t->set, j)) t->hash[j] = sfield__hash(t->hash[j], 1);
#endif
        /* Up to number `prefix` of the order T is that of all lights, and is rounded. */
        t->hash[j] = sfield__hash(t->hash[j], prefix) | 1;
        t->prefix[j] = prefix;
    }
}

/* Returns whether no line from a lane to the middle of a meets the inscribed sphere of b. Such a line is
   nowhere farther from the line of the tile's middle than the lanes are from that middle. */
static int sfield__is_aside(const sfield__tile *t, const sfield__item *a, const sfield__item *b)
{
    const sfield__v3 m = sfield__v3_load(t->middle), v = sfield__v3_sub(sfield__v3_load(a->center[0]), m);
    const sfield__v3 c = sfield__v3_cross(v, sfield__v3_sub(sfield__v3_load(b->center[0]), m));
    const float most = 1.001f * (b->inscribed + t->extent);
    return sfield__v3_dot(c, c) > most * most * sfield__v3_dot(v, v);
}

/* Returns, by the second rule of section 4.2, the lanes of a mask for which the bounding sphere of occluder i
   is inside the cone of a nearer inscribed one. */
static uint32_t sfield__find_hidden(const sfield__tile *t, uint32_t i, uint32_t lanes)
{
    const sfield__item *a = &t->s->item[t->item[i]];
    const float a2 = a->radius[0] * a->radius[0], *near_i = t->d2 + i * SFIELD__LANES;
    uint32_t j, l, k, hidden = 0;
    for (j = 0; j < t->count; j++) {
        const sfield__item *b = &t->s->item[t->item[j]];
        const float b2 = b->inscribed * b->inscribed, *near_j = t->d2 + j * SFIELD__LANES;
        /* Then occluder j hides i from no lane. */
        if (!(t->widest[j] * t->farthest[i] > a->radius[0]) || j == i) continue;
        if (sfield__is_aside(t, a, b)) continue;
        for (l = 0; l < SFIELD__LANES; l++) {
            float d2 = near_i[l], e2 = near_j[l], dot = 0;
            float sines, cosines;
            if (!((lanes & ~hidden) >> l & 1) || e2 >= d2 || a2 >= d2 || b2 >= e2 || b2 * d2 <= a2 * e2)
                continue;
            if (t->factor[j * SFIELD__LANES + l] < 1) continue;
            for (k = 0; k < 3; k++)
                dot += (a->center[0][k] - t->p[16 * k + l]) * (b->center[0][k] - t->p[16 * k + l]);
            sines = a->radius[0] * b->inscribed;
            cosines = sqrtf((d2 - a2) * (e2 - b2));
            if (dot >= cosines + sines) hidden |= 1u << l;
        }
    }
    return hidden;
}

/* ==== src/shadowfield/shade_factors.h ==== */

/* ---- shading: the factors of the triple product ---- */

/* Evaluates the basis at 16 directions in planes, in float. */
static void sfield__evaluate_basis16(uint32_t bands, const float *d, float *out)
{
    float cm[16], sm[16], older[16];
    float now[16], diagonal = sfield__y00;
    uint32_t l, m, i;
    for (i = 0; i < 16; i++) {
        cm[i] = 1;
        sm[i] = 0;
    }
    for (m = 0; m < bands; m++) {
        float two = m ? 1.41421356f * diagonal : diagonal;
        for (i = 0; i < 16; i++) {
            older[i] = 0;
            now[i] = two;
        }
        for (l = m; l < bands; l++) {
            float fl = (float)l, fm = (float)m, back = sqrtf((fl * fl - fm * fm) / (4 * fl * fl - 1));
            float a = sqrtf((4 * (fl + 1) * (fl + 1) - 1) / ((fl + 1) * (fl + 1) - fm * fm));
            float *plus = out + (l * l + l + m) * 16, *minus = out + (l * l + l - m) * 16;
            if (l == 0) back = 0;
            for (i = 0; i < 16; i++) {
                float next = a * (d[32 + i] * now[i] - back * older[i]);
                minus[i] = now[i] * sm[i];
                plus[i] = now[i] * cm[i];
                older[i] = now[i];
                now[i] = next;
            }
        }
        diagonal *= sqrtf((2 * (float)m + 3) / (2 * (float)m + 2));
        for (i = 0; i < 16; i++) {
            float c = cm[i] * d[i] - sm[i] * d[16 + i];
            sm[i] = cm[i] * d[16 + i] + sm[i] * d[i];
            cm[i] = c;
        }
    }
}

#ifndef SFIELD_WITHOUT_GLOSS
static void sfield__start_gloss(sfield__tile *t);
#endif

/* Computes T before any other entity: own visibility times the cosine, and that times the BRDF. */
static void sfield__start_tile(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    const sfield_field *self = t->set->self;
    uint32_t k, l, i;
    if (self) {
        for (i = 0; i < SFIELD__LANES; i++) {
            const uint8_t *q = self->sample + (t->first + (i < t->lanes ? i : 0)) * self->h.stride;
            for (k = 0; k < s->coefs; k++)
                t->start[k * SFIELD__LANES + i] = self->scale[k] * (float)q[k] + self->bias[k];
        }
        if (t->set->entity && !s->item[t->set->entity - 1].identity)
            sfield__rotate16(&s->rotation[t->set->entity - 1], t->start, t->start, SFIELD__LANES, 0, s->simd);
    } else {
        float factor[SFIELD_MAX_BANDS];
        sfield_sh_cosine(s->desc.bands, factor);
        sfield__evaluate_basis16(s->desc.bands, t->n, t->start);
        for (l = 0, k = 0; l < s->desc.bands; l++)
            for (; k < (l + 1) * (l + 1) * SFIELD__LANES; k++) t->start[k] *= factor[l];
    }
#ifndef SFIELD_WITHOUT_GLOSS
    if (t->chains > 1) sfield__start_gloss(t);
#endif
}

/* Interpolates some lanes of a field at their places, times a factor, in planes; the others are 0. */
static void sfield__fetch_lanes(const sfield_field *f, const sfield__place *at, uint32_t lanes,
                            const float *factor, float *rows, float *planes, int simd)
{
    const uint32_t n = f->planes;
    uint32_t group[SFIELD__LANES], count = sfield__group_lanes(at, lanes, group, simd), i, l;
    for (i = 0; i < count; i++) {
        sfield__eight e;
        float own[SFIELD__LANES];
        for (l = 0; !(group[i] >> l & 1);) l++;
        sfield__load_eight(f, (size_t)at->base[l], (size_t)at->shell[l], 0, n, &e, simd);
        sfield__select16(factor, SFIELD__LANES, group[i], own, simd);
        sfield__mix_eight(&e, at, own, i > 0, planes, simd);
    }
    if (count) return;
    for (l = 0; l < SFIELD__LANES; l++, rows += n) {
        sfield__between b;
        if (!(lanes >> l & 1)) {
            memset(rows, 0, n * sizeof *rows);
            continue;
        }
        b = sfield__find_between(at, (int)l, factor[l]);
        sfield__mix_samples(f, &b, n, rows, simd);
    }
    sfield__rows_to_planes(rows - SFIELD__LANES * n, n, n, planes, simd);
}

/* Fetches alpha (or log visibility) of occluder i for all lanes, in planes, in the world. */
static void sfield__fetch_occluder(sfield__tile *t, uint32_t i)
{
    const sfield_scene *s = t->s;
    const sfield__item *it = &s->item[t->item[i]];
    float local[48], *planes = it->identity && s->planes == s->coefs ? NULL : t->planes;
    float *out = t->occlusion + (size_t)i * s->coefs * SFIELD__LANES;
    sfield__place at;
    uint32_t hidden;
    if (t->state[i] != SFIELD__NOT_FETCHED) return;
    hidden = sfield__find_hidden(t, i, t->used[i]);
    t->stats.culled_hidden += sfield__popcount(hidden);
    t->shown[i] = t->used[i] & ~hidden;
    t->state[i] = t->shown[i] ? SFIELD__FETCHED : SFIELD__ALL_HIDDEN;
    if (!t->shown[i]) return;
    sfield__move_to_local(it, 0, t->p, local, s->simd);
    sfield__locate16(it->e.occlusion, local, &at, s->simd);
    sfield__fetch_lanes(it->e.occlusion, &at, t->shown[i], t->factor + (size_t)i * SFIELD__LANES, t->rows,
                    planes ? planes : out, s->simd);
    if (!planes) return;
    if (it->identity) memcpy(out, planes, s->coefs * SFIELD__LANES * sizeof *out);
    else sfield__rotate16(&s->rotation[t->item[i]], planes, out, SFIELD__LANES, 0, s->simd);
}

/* Multiplies t by the visibility of occluder i, for the lanes of a mask. */
static void sfield__apply_occluder(sfield__tile *t, uint32_t i, uint32_t mask, float *chain)
{
    const sfield_scene *s = t->s;
    const float *o = t->occlusion + (size_t)i * s->coefs * SFIELD__LANES;
    int c;
    if (t->state[i] == SFIELD__ALL_HIDDEN || !mask) return;
    if (mask != t->used[i]) {
        sfield__select16(o, s->coefs * SFIELD__LANES, mask, t->turned, s->simd);
        o = t->turned;
    }
    t->stats.products += sfield__popcount(mask);
    for (c = 0; c < t->chains; c++, chain += s->coefs * SFIELD__LANES)
        sfield__product16(s->algebra, chain, o, chain, SFIELD__LANES, 1);
}

/* ==== src/shadowfield/shade_lights.h ==== */

/* ---- shading: what lights add ---- */

/* Adds a source's dot products with T: of one channel, where the others are multiples of it. */
static void sfield__add_source(const sfield__item *it, const float (*sum)[SFIELD__LANES], float *rgb)
{
    const sfield_field *f = it->e.source;
    uint32_t c, l;
    for (c = 0; c < 3; c++, rgb += SFIELD__LANES) {
        const float *row = sum[f->tone < 3 ? f->tone : c], tint = it->e.tint[c];
        const float ratio = f->tone < 3 ? f->ratio[c] : 1.0f;
        float own[SFIELD__LANES];               /* a copy, so that compilers know it apart from rgb */
        for (l = 0; l < SFIELD__LANES; l++) own[l] = ratio * row[l];
        for (l = 0; l < SFIELD__LANES; l++) rgb[l] += tint * own[l];
    }
}

/* Computes the dot products of a source's coefficients with T. Each lane is interpolated by itself. */
static void sfield__shine_single(const sfield__tile *t, const sfield__item *it, const sfield__place *at,
                                 const float *chain, float (*sum)[SFIELD__LANES])
{
    const sfield_field *f = it->e.source;
    const uint32_t n = t->s->coefs, begin = f->tone < 3 ? f->tone : 0, end = f->tone < 3 ? f->tone + 1 : 3;
    uint32_t frame[2], c, k, l;
    const float time = sfield__frames_at(f, it->e.time, &frame[0], &frame[1]);
    for (k = 0; k < (time > 0 ? 2u : 1u); k++) {
        float share[SFIELD__LANES];
        for (l = 0; l < SFIELD__LANES; l++) share[l] = k ? time : 1 - time;
        for (c = begin; c < end; c++)
            sfield__dot_single(f, at, frame[k], share, c * n, n, chain, t->rows, sum[c], t->s->simd);
    }
}

/* Does what sfield__shine_single does for lanes that share samples, group by group, which costs less. Returns
   0, with nothing done, if they do not share enough. */
static int sfield__shine_shared(const sfield__tile *t, const sfield__item *it, const sfield__place *at,
                                const float *chain, float (*sum)[SFIELD__LANES])
{
    const sfield_field *f = it->e.source;
    const uint32_t n = t->s->coefs, shells = f->h.shells;
    const uint32_t begin = f->tone < 3 ? f->tone : 0, end = f->tone < 3 ? f->tone + 1 : 3;
    const size_t samples = 6 * (size_t)f->h.position_side * f->h.position_side * shells;
    uint32_t group[SFIELD__LANES], frame[2];
    uint32_t i, k, c, l;
    const uint32_t count = sfield__group_lanes(at, t->in_view, group, t->s->simd);
    float weight[2][SFIELD__LANES], own[SFIELD__LANES];
    const float time = sfield__frames_at(f, it->e.time, &frame[0], &frame[1]);
    for (l = 0; l < SFIELD__LANES; l++) {
        weight[0][l] = 1 - time;
        weight[1][l] = time;
    }
    for (i = 0; i < count; i++) {
        for (l = 0; !(group[i] >> l & 1);) l++;
        for (k = 0; k < (time > 0 ? 2u : 1u); k++) {
            sfield__select16(weight[k], SFIELD__LANES, group[i], own, t->s->simd);
            for (c = begin; c < end; c++) {
                sfield__eight e;
                sfield__load_eight(f, frame[k] * samples + (size_t)at->base[l],
                                   frame[k] * shells + (size_t)at->shell[l], c * n, n, &e, t->s->simd);
                sfield__dot_eight(&e, at, own, chain, sum[c], t->s->simd);
            }
        }
    }
    return count != 0;
}

/* Does what sfield__shine_single does for bands whose coefficients do not fill eights: one after another. */
static void sfield__shine_rows(const sfield__tile *t, const sfield__item *it, const sfield__place *at,
                               const float *chain, float (*sum)[SFIELD__LANES])
{
    const sfield_field *f = it->e.source;
    const sfield_scene *s = t->s;
    float *rows = t->rows;
    uint32_t l, c, k;
    for (l = 0; l < SFIELD__LANES; l++)
        sfield__fetch_lane(f, at, (int)l, it->e.time, f->h.stride, rows + l * f->h.stride, s->simd);
    for (l = 0; l < SFIELD__LANES; l++)
        for (c = 0; c < 3; c++) {
            const float *row = rows + l * f->h.stride + c * s->planes;
            if (f->tone < 3 && c != f->tone) continue;
            for (k = 0; k < s->coefs; k++) sum[c][l] += row[k] * chain[k * SFIELD__LANES + l];
        }
}

/* Adds T . source of light j to rgb, three channels. */
static void sfield__shine_light(const sfield__tile *t, uint32_t j, const float *chain, float *rgb)
{
    const sfield_scene *s = t->s;
    const sfield__item *it = &s->item[s->light[j]];
    float local[48], sum[3][SFIELD__LANES] = { { 0 } };
    sfield__place at;
    sfield__move_to_local(it, 1, t->p, local, s->simd);
    sfield__locate16(it->e.source, local, &at, s->simd);
    if (!it->identity) {
        sfield__rotate16(&s->rotation[s->light[j]], chain, t->turned, SFIELD__LANES, 1, s->simd);
        chain = t->turned;
    }
    if (s->coefs % 8 != 0) sfield__shine_rows(t, it, &at, chain, sum);
    else if (!sfield__shine_shared(t, it, &at, chain, sum)) sfield__shine_single(t, it, &at, chain, sum);
    sfield__add_source(it, (const float (*)[SFIELD__LANES])sum, rgb);
}

static void sfield__sum_lights(const sfield__tile *t, int chain, float *rgb)
{
    const sfield_scene *s = t->s;
    uint32_t j, c, k;
    uint32_t l, n = s->coefs * SFIELD__LANES;
    memset(rgb, 0, 3 * SFIELD__LANES * sizeof *rgb);
    for (j = 0; j < t->lights; j++)
        if (!sfield__is_own(t, j))
            sfield__shine_light(t, j, t->t + ((size_t)j * (size_t)t->chains + (size_t)chain) * n, rgb);
    if (!s->has_sky && !s->has_sun) return;
    for (c = 0; c < 3; c++) {
        const float *sky = s->sky_now + c * s->planes;
        const float *light = t->t + ((size_t)t->lights * (size_t)t->chains + (size_t)chain) * n;
        for (k = 0; k < s->coefs; k++)
            for (l = 0; l < SFIELD__LANES; l++)
                rgb[c * SFIELD__LANES + l] += sky[k] * light[k * SFIELD__LANES + l];
    }
}

static void sfield__store_rgb(const sfield__tile *t, const float *rgb, float factor, float *out)
{
    uint32_t l, c;
    for (l = 0; l < t->lanes; l++)
        for (c = 0; c < 3; c++)
            out[3 * (t->first + l) + c] = t->in_view >> l & 1 ? rgb[c * SFIELD__LANES + l] * factor : 0.0f;
}

#ifndef SFIELD_WITHOUT_GLOSS
static void sfield__write_materials(const sfield__tile *t);
#endif

static void sfield__write_outputs(sfield__tile *t)
{
    const sfield_points *set = t->set;
    float rgb[3 * SFIELD__LANES];
    uint32_t l, n = t->s->coefs * SFIELD__LANES;
    const float *sky = t->t + (size_t)t->lights * (size_t)t->chains * n;
#ifndef SFIELD_WITHOUT_GLOSS
    if (t->chains == 3) {
        sfield__write_materials(t);
        return;
    }
#endif
    if (set->rgb) {
        sfield__sum_lights(t, 0, rgb);
        sfield__store_rgb(t, rgb, 0.318309886f, set->rgb);
    }
#ifndef SFIELD_WITHOUT_GLOSS
    if (set->gloss) {
        if (t->chains == 2) sfield__sum_lights(t, 1, rgb);
        else memset(rgb, 0, sizeof rgb);
        sfield__store_rgb(t, rgb, 1, set->gloss);
        memset(rgb, 0, sizeof rgb);
        if (set->grazing) sfield__store_rgb(t, rgb, 1, set->grazing);
    }
#endif
    for (l = 0; l < t->lanes && set->ambient; l++)
        set->ambient[t->first + l] = t->in_view >> l & 1 ? sky[l] * 0.318309886f / sfield__y00 : 0.0f;
}

/* ==== src/shadowfield/gloss.h ==== */

/* ---- gloss: BRDFs as harmonics ---- */

/* Returns what stands in the array of points for point i, where a stride of 0 means one for all. */
static const float *sfield__value_of(const float *base, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)(const void *)base + i * stride);
}

/* The BRDF of glTF 2.0, appendix B, is F D V + (1 - F) base (1 - metallic) / pi. Schlick's F is F0 (1 - s) +
   s, where s = (1 - v . h)^5. So three kernels that know no colours make it up:

     SFIELD__DIFFUSE   (1 - s) / pi     times (1 - F0) base (1 - metallic)
     SFIELD__FACING    D V (1 - s)      times F0
     SFIELD__GRAZING   D V s

   They depend on the roughness and on the angle between view and normal alone. Their coefficients are kept
   for a grid of both, in the frame in which the normal is z and the view lies in the plane of x and z.
   Kernels are even in y there, so that only the coefficients of order m >= 0 are not 0. Each kernel is kept
   twice: times the cosine, and without it for points whose self-visibility brings the cosine along. The
   second are continued below the horizon, where their partner is 0, by |cos|: the less they jump there, the
   less of the product is lost in the bands. */
enum {
    SFIELD__DIFFUSE, SFIELD__FACING, SFIELD__GRAZING, SFIELD__KERNELS,
    SFIELD__ROUGHNESSES = 24,       /* from 0 to 1 */
    SFIELD__ANGLES = 48,            /* sqrt(1 - cos) from 0 to 1 */
    SFIELD__DRAWS = 32              /* in each of two dimensions, for a node of the grid */
};

struct sfield__brdf {
    sfield_rotation quarter;        /* a quarter turn about x */
    uint32_t bands, half;           /* n; n (n + 1) / 2 coefficients of a kernel */
    float   *table;                 /* [roughness][angle][times the cosine, without][kernel] half */
};

/* Returns alpha of a roughness: its square, not below 0.002, so that lobes keep some width. */
static float sfield__alpha_of(float roughness)
{
    return roughness * roughness > 0.002f ? roughness * roughness : 0.002f;
}

/* Adds weighted values of the basis at sixteen directions to the coefficients of order m >= 0. */
static SFIELD__COLD void sfield__add_half(uint32_t bands, const float *basis, const float *weight, float *out)
{
    uint32_t l, m, i;
    for (l = 0; l < bands; l++)
        for (m = 0; m <= l; m++, out++) {
            const float *y = basis + (l * l + l + m) * 16;
            float sum = 0;
            for (i = 0; i < 16; i++) sum += weight[i] * y[i];
            *out += sum;
        }
}

/* Finds draw `at` of a node: its first number, 0..1, and of its angle about z, 0..pi, sine and cosine. */
static SFIELD__COLD void sfield__find_draw(uint32_t at, double *u, double turn[2])
{
    const double step = 1.0 / (double)SFIELD__DRAWS;
    *u = (at / SFIELD__DRAWS + 0.5) * step;
    sfield__sincos_d(sfield__pi * (at % SFIELD__DRAWS + 0.5) * step, &turn[0], &turn[1]);
}

/* Draws a direction l by the half vectors that a view sees, by spherical caps (Dupuy and Benyoub, HPG 2023),
   in the frame in which the normal is z and the view lies in the plane of x and z. go: what Smith's shadowing
   has of the view. Writes s = (1 - v . h)^5 and returns D V over the density of l. */
static float sfield__draw_direction(const float *view, float alpha, float go, double u, const double *turn,
                                    float *l, float *s)
{
    const float a2 = alpha * alpha, scale = 1 / sqrtf(a2 * view[0] * view[0] + view[2] * view[2]);
    const float z0 = view[2] * scale, z = (float)(1 - u) * (1 + z0) - z0;
    const float ring = sqrtf(z * z < 1 ? 1 - z * z : 0);
    const float x = alpha * (ring * (float)turn[1] + alpha * view[0] * scale);
    const float y = alpha * ring * (float)turn[0];
    const float unit = 1 / sqrtf(x * x + y * y + (z + z0) * (z + z0));
    const float vh = unit * (x * view[0] + (z + z0) * view[2]), off = 1 - (vh < 1 ? vh : 1);
    l[0] = 2 * vh * unit * x - view[0];
    l[1] = 2 * vh * unit * y;
    l[2] = 2 * vh * unit * (z + z0) - view[2];
    *s = off * off * (off * off) * off;
    return (view[2] + go) / (fabsf(l[2]) * go + view[2] * sqrtf(a2 + (1 - a2) * l[2] * l[2]));
}

/* Adds up the kernels of D V for one roughness and view. Directions are drawn on an even grid: what is added
   up is smooth then, however narrow the lobe is. Of directions mirrored in y one is enough. */
static SFIELD__COLD void sfield__add_specular(const sfield__brdf *b, float alpha, const float *view,
                                              float *node)
{
    const float a2 = alpha * alpha, go = sqrtf(a2 + (1 - a2) * view[2] * view[2]);
    const float share = 1.0f / (float)(SFIELD__DRAWS * SFIELD__DRAWS);
    const uint32_t half = b->half, other = SFIELD__KERNELS * half;
    float d[48], weight[4][16], basis[SFIELD_MAX_COEFS * 16];
    uint32_t i, at, k;
    for (at = 0; at < SFIELD__DRAWS * SFIELD__DRAWS; at++) {
        double u, turn[2];
        float l[3], s, all;
        sfield__find_draw(at, &u, turn);
        all = sfield__draw_direction(view, alpha, go, u, turn, l, &s) * share;
        i = at % 16;
        for (k = 0; k < 3; k++) d[16 * k + i] = l[k];
        weight[2][i] = all * (1 - s);
        weight[3][i] = all * s;
        weight[0][i] = l[2] > 0 ? l[2] * weight[2][i] : 0;
        weight[1][i] = l[2] > 0 ? l[2] * weight[3][i] : 0;
        if (i < 15) continue;
        sfield__evaluate_basis16(b->bands, d, basis);
        sfield__add_half(b->bands, basis, weight[0], node + SFIELD__FACING * half);
        sfield__add_half(b->bands, basis, weight[1], node + SFIELD__GRAZING * half);
        sfield__add_half(b->bands, basis, weight[2], node + other + SFIELD__FACING * half);
        sfield__add_half(b->bands, basis, weight[3], node + other + SFIELD__GRAZING * half);
    }
}

/* Adds up the kernel of the diffuse part, over the hemisphere by its cosine and over the sphere. */
static SFIELD__COLD void sfield__add_diffuse(const sfield__brdf *b, const float *view, float *node)
{
    const float share = 1.0f / (float)(SFIELD__DRAWS * SFIELD__DRAWS);
    float d[48], weight[16], basis[SFIELD_MAX_COEFS * 16];
    uint32_t whole, at, i;
    for (whole = 0; whole < 2; whole++)
        for (at = 0; at < SFIELD__DRAWS * SFIELD__DRAWS; at++) {
            double u, turn[2];
            float s, z, ring;
            sfield__find_draw(at, &u, turn);
            z = whole ? (float)(2 * u - 1) : (float)sqrt(u);
            ring = sqrtf(1 - z * z);
            i = at % 16;
            d[i] = ring * (float)turn[1];
            d[16 + i] = ring * (float)turn[0];
            d[32 + i] = z;
            s = 0.5f + 0.5f * (d[i] * view[0] + z * view[2]);
            s = 1 - sqrtf(s > 0 ? s < 1 ? s : 1 : 0);
            weight[i] = (1 - s * s * (s * s) * s) * (whole ? 4.0f : 1.0f) * share;
            if (i < 15) continue;
            sfield__evaluate_basis16(b->bands, d, basis);
            sfield__add_half(b->bands, basis, weight,
                             node + (whole * SFIELD__KERNELS + SFIELD__DIFFUSE) * b->half);
        }
}

/* Fills in the kernels of one view angle, for all roughnesses. */
static SFIELD__COLD void sfield__fill_angle(void *context, size_t angle)
{
    const sfield__brdf *b = (const sfield__brdf *)context;
    const size_t size = 2 * (size_t)SFIELD__KERNELS * b->half;
    const float x = (float)angle / (SFIELD__ANGLES - 1);
    float *node = b->table + angle * size, *first = node, view[3];
    uint32_t i, k;
    /* an eye on the horizon would see nothing of the surface */
    view[2] = x * x < 0.999f ? 1 - x * x : 1e-3f;
    view[1] = 0;
    view[0] = sqrtf(1 - view[2] * view[2]);
    sfield__add_diffuse(b, view, node);
    for (i = 0; i < SFIELD__ROUGHNESSES; i++, node += SFIELD__ANGLES * size) {
        for (k = 0; k < size && i; k++) node[k] = k % (size / 2) < b->half ? first[k] : 0;
        sfield__add_specular(b, sfield__alpha_of((float)i / (SFIELD__ROUGHNESSES - 1)), view, node);
    }
}

SFIELD_DEF SFIELD__COLD size_t sfield_sh_brdf(uint32_t bands, const sfield_system *system, float *table)
{
    const uint32_t half = bands * (bands + 1) / 2;
    const size_t floats = (size_t)SFIELD__ROUGHNESSES * SFIELD__ANGLES * 2 * SFIELD__KERNELS * half;
    sfield__brdf b;
    size_t i;
    if (bands < 1 || bands > SFIELD_MAX_BANDS) return 0;
    if (!table) return floats;
    memset(&b, 0, sizeof b);
    b.bands = bands;
    b.half = half;
    b.table = table;
    memset(table, 0, floats * sizeof *table);
    if (system && system->parallel_for)
        system->parallel_for(system->user, SFIELD__ANGLES, sfield__fill_angle, &b);
    else
        for (i = 0; i < SFIELD__ANGLES; i++) sfield__fill_angle(&b, i);
    return floats;
}

/* Makes the table of a scene when the first set with materials comes. */
static SFIELD__COLD sfield_result sfield__make_brdf(sfield_scene *s)
{
    static const float turn[16] = { 1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1 };
    const size_t floats = sfield_sh_brdf(s->desc.bands, NULL, NULL);
    sfield__brdf *b = (sfield__brdf *)sfield__alloc(&s->allocator, sizeof *b + floats * sizeof(float));
    if (!b) return SFIELD_ERR_ALLOC;
    b->bands = s->desc.bands;
    b->half = b->bands * (b->bands + 1) / 2;
    b->table = (float *)(void *)(b + 1);
    (void)sfield_sh_brdf(b->bands, &s->desc.system, b->table);
    (void)sfield_sh_rotation(s->algebra, turn, &b->quarter);
    s->brdf = b;
    return SFIELD_OK;
}

/* Turns sixteen functions about z, each by an angle of its own. */
static void sfield__turn_lanes(uint32_t bands, const float *cosine, const float *sine, float *planes)
{
    float c[16], s[16];
    uint32_t l, m, i;
    for (i = 0; i < 16; i++) {
        c[i] = 1;
        s[i] = 0;
    }
    for (m = 1; m < bands; m++) {
        for (i = 0; i < 16; i++) {
            const float next = c[i] * cosine[i] - s[i] * sine[i];
            s[i] = s[i] * cosine[i] + c[i] * sine[i];
            c[i] = next;
        }
        for (l = m; l < bands; l++) {
            float *plus = planes + (l * l + l + m) * 16, *minus = planes + (l * l + l - m) * 16;
            for (i = 0; i < 16; i++) {
                const float p = plus[i], q = minus[i];
                plus[i] = c[i] * p - s[i] * q;
                minus[i] = s[i] * p + c[i] * q;
            }
        }
    }
}

typedef struct sfield__frames { float c[3][16], s[3][16]; } sfield__frames;

/* Finds the three angles, as cosines and sines, that turn z to the normal and the plane of x and z to the
   view: about z, about y, and about z again. Writes the cosines between normal and view. */
static void sfield__find_frames(const sfield__tile *t, sfield__frames *f, float *facing)
{
    uint32_t i;
    for (i = 0; i < 16; i++) {
        const float x = t->n[i], y = t->n[16 + i], z = t->n[32 + i], ring = sqrtf(x * x + y * y);
        const float *v = t->view + i;
        const float ca = ring > 1e-6f ? x / ring : 1, sa = ring > 1e-6f ? y / ring : 0;
        const float p = z * ca * v[0] + z * sa * v[16] - ring * v[32], q = ca * v[16] - sa * v[0];
        const float length = sqrtf(p * p + q * q), unit = 1 / sqrtf(ring * ring + z * z);
        f->c[0][i] = length > 1e-6f ? p / length : 1;
        f->s[0][i] = length > 1e-6f ? q / length : 0;
        f->c[1][i] = z * unit;
        f->s[1][i] = ring * unit;
        f->c[2][i] = ca;
        f->s[2][i] = sa;
        facing[i] = x * v[0] + y * v[16] + z * v[32];
    }
}

/* Interpolates the kernels of a lane between four nodes of the table, into planes of order m >= 0. */
static SFIELD__COLD void sfield__mix_kernels(const sfield__brdf *b, float roughness, float facing,
                                             uint32_t whole,
                                float *planes, size_t kernel)
{
    const size_t size = 2 * (size_t)SFIELD__KERNELS * b->half;
    const float x = sqrtf(facing < 1 ? facing > 0 ? 1 - facing : 1 : 0) * (SFIELD__ANGLES - 1);
    const float y = roughness * (SFIELD__ROUGHNESSES - 1);
    const uint32_t i = x < SFIELD__ANGLES - 2 ? (uint32_t)x : (uint32_t)SFIELD__ANGLES - 2;
    const uint32_t j = y < SFIELD__ROUGHNESSES - 2 ? (uint32_t)y : (uint32_t)SFIELD__ROUGHNESSES - 2;
    const float u = x - (float)i, v = y - (float)j;
    const float *p = b->table + ((size_t)j * SFIELD__ANGLES + i) * size + whole * size / 2;
    const float *q = p + SFIELD__ANGLES * size;
    uint32_t k, l, m;
    for (k = 0; k < SFIELD__KERNELS; k++)
        for (l = 0; l < b->bands; l++)
            for (m = 0; m <= l; m++, p++, q++)
                planes[k * kernel + (l * l + l + m) * 16] =
                    (1 - v) * ((1 - u) * p[0] + u * p[size]) + v * ((1 - u) * q[0] + u * q[size]);
}

/* Computes T of the metal-rough BRDF before any other entity: kernels for the lanes' roughness and view,
   turned into the world, and times the self-visibility where there is one. */
static void sfield__start_materials(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    const sfield_points *set = t->set;
    const sfield__brdf *b = s->brdf;
    const uint32_t n = s->coefs * SFIELD__LANES;
    float facing[16], *out = set->self ? t->t : t->start;
    sfield__frames f;
    uint32_t i, k;
    sfield__find_frames(t, &f, facing);
    memset(out, 0, SFIELD__KERNELS * n * sizeof *out);
    for (i = 0; i < SFIELD__LANES; i++) {
        const float *m = sfield__value_of(set->materials, set->material_stride,
                                          t->first + (i < t->lanes ? i : 0));
        sfield__mix_kernels(b, m[4], facing[i], set->self != NULL, out + i, n);
    }
    for (k = 0; k < SFIELD__KERNELS; k++, out += n) {
        sfield__turn_lanes(b->bands, f.c[0], f.s[0], out);
        sfield__rotate16(&b->quarter, out, out, SFIELD__LANES, 0, s->simd);
        sfield__turn_lanes(b->bands, f.c[1], f.s[1], out);
        sfield__rotate16(&b->quarter, out, out, SFIELD__LANES, 1, s->simd);
        sfield__turn_lanes(b->bands, f.c[2], f.s[2], out);
    }
    if (!set->self) return;
    for (k = SFIELD__KERNELS; k-- > 0;)         /* the self-visibility is the first T, so it goes last */
        sfield__product16(s->algebra, t->start, t->t + k * n, t->start + k * n, SFIELD__LANES, 0);
}

/* Returns the exponent of a point's lobe, in its range. */
static float sfield__exponent_of(const sfield_points *set, size_t index)
{
    const float n = *sfield__value_of(set->exponents, set->exponent_stride, index);
    return n > 1 ? (n < 1000 ? n : 1000) : 1;
}

/* Computes the lobe cos^n about the mirrored view, times (n + 2) / 2 pi. Its moments over x = cos are
   1/(n+1), 1/(n+2) and then I_l = I_(l-2) (n - l + 2) / (n + l + 1). */
static void sfield__fill_lobe(const sfield__tile *t, float *out)
{
    const sfield_points *set = t->set;
    uint32_t bands = t->s->desc.bands, i, l, k;
    float d[48], before[16], now[16], n[16];
    for (i = 0; i < 16; i++) {
        size_t at = t->first + (i < t->lanes ? i : 0);
        float dot = 0;
        for (k = 0; k < 3; k++) dot += t->n[16 * k + i] * t->view[16 * k + i];
        for (k = 0; k < 3; k++) d[16 * k + i] = 2 * dot * t->n[16 * k + i] - t->view[16 * k + i];
        n[i] = sfield__exponent_of(set, at);
        before[i] = (n[i] + 2) / (n[i] + 1);
        now[i] = 1;
    }
    sfield__evaluate_basis16(bands, d, out);
    for (l = 0; l < bands; l++) {
        for (k = l * l; k < (l + 1) * (l + 1); k++)
            for (i = 0; i < 16; i++) out[k * 16 + i] *= l == 0 ? before[i] : now[i];
        for (i = 0; i < 16 && l >= 1; i++) {
            float next = before[i] * (n[i] - (float)l + 1) / (n[i] + (float)l + 2);
            before[i] = now[i];
            now[i] = next;
        }
    }
}

/* Adds to a hash what T of some points depends on by their BRDFs: where their eyes are, their exponents or
   materials. */
static SFIELD__COLD uint64_t sfield__hash_brdfs(uint64_t h, const sfield_points *set, size_t first,
                                                uint32_t count)
{
    const size_t words = set->materials ? 5 : 1, stride = set->materials ? set->material_stride
                                                                         : set->exponent_stride;
    const float *of = set->materials ? set->materials : set->exponents;
    uint32_t l;
    h = sfield__hash(h, words);
    for (l = 0; l < count; l++) {
        h = sfield__hash_bytes(h, sfield__row(set->to_eye, set->to_eye_stride, first + l), 3);
        if (l == 0 || stride) h = sfield__hash_bytes(h, sfield__value_of(of, stride, first + l), words);
    }
    return h;
}

/* Computes T with a BRDF: of the lobe beside that of rgb, or of all kernels. */
static void sfield__start_gloss(sfield__tile *t)
{
    float *lobe = t->start + t->s->coefs * SFIELD__LANES;
    if (t->set->materials) {
        sfield__start_materials(t);
        return;
    }
    sfield__fill_lobe(t, lobe);
    sfield__product16(t->s->algebra, t->start, lobe, lobe, SFIELD__LANES, 0);
}

/* Returns F0 of a material, in one channel. */
static float sfield__facing_of(const float *material, uint32_t channel)
{
    return 0.04f + material[3] * (material[channel] - 0.04f);
}

/* Gives sums of the kernels' T with all lights their colours: rgb gets what is diffuse, gloss the rest. */
static SFIELD__COLD void sfield__color_tile(const sfield__tile *t, float *rgb, float *facing,
                                            const float *grazing)
{
    uint32_t l, c;
    for (l = 0; l < t->lanes; l++) {
        const float *m = sfield__value_of(t->set->materials, t->set->material_stride, t->first + l);
        for (c = 0; c < 3; c++) {
            const float f0 = sfield__facing_of(m, c);
            rgb[c * SFIELD__LANES + l] *= 1 - f0;
            facing[c * SFIELD__LANES + l] *= f0;
            facing[c * SFIELD__LANES + l] += grazing[c * SFIELD__LANES + l];
        }
    }
}

static void sfield__write_materials(const sfield__tile *t)
{
    float sum[SFIELD__KERNELS][3 * SFIELD__LANES];
    int k;
    for (k = 0; k < SFIELD__KERNELS; k++) sfield__sum_lights(t, k, sum[k]);
    sfield__color_tile(t, sum[SFIELD__DIFFUSE], sum[SFIELD__FACING], sum[SFIELD__GRAZING]);
    if (t->set->rgb) sfield__store_rgb(t, sum[SFIELD__DIFFUSE], 1, t->set->rgb);
    if (t->set->grazing) sfield__store_rgb(t, sum[SFIELD__GRAZING], 1, t->set->grazing);
    sfield__store_rgb(t, sum[SFIELD__FACING], 1, t->set->gloss);
}

/* Checks what a set with gloss needs, before its directions are read. */
static SFIELD__COLD sfield_result sfield__check_gloss(const sfield__logger *log, const sfield_points *p)
{
    size_t i;
    uint32_t k;
    if (p->exponents && p->materials)
        return sfield__fail(log, SFIELD_ERR_ARGUMENT, "points->exponents", "is there beside materials");
    if (!p->to_eye)
        return sfield__fail(log, SFIELD_ERR_ARGUMENT, "points->to_eye",
                            p->materials ? "is NULL, but gloss and materials are there"
                                         : "is NULL, but gloss and exponents are there");
    if (!p->materials) return SFIELD_OK;
    if (p->ambient)
        return sfield__fail(log, SFIELD_ERR_ARGUMENT, "points->ambient",
                            "is there beside gloss and materials, which have none");
    if (!sfield__check_value(log, !p->material_stride || sfield__stride_valid(p->material_stride, 20),
                             "points->material_stride", (double)p->material_stride,
                             "0, or a multiple of 4 of at least 20"))
        return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < (p->material_stride ? p->count : 1); i++)
        for (k = 0; k < 5; k++) {
            const float x = sfield__value_of(p->materials, p->material_stride, i)[k];
            if (sfield__in(x, 0, 1)) continue;
            sfield__log_element(log, "points->materials", i,
                                k < 3    ? "has the base colour"
                                : k == 3 ? "has the metallic"
                                         : "has the roughness",
                                (double)x, "0..1");
            return SFIELD_ERR_INPUT;
        }
    return SFIELD_OK;
}

/* ==== src/shadowfield/shade_order.h ==== */

/* ---- shading: from near to far, and for incident radiance from far to near ---- */

/* Shades 16 points as figure 5 of the paper does: T is multiplied by the visibility of occluders from near to
   far, and each light takes the T of the moment. Occluders commute up to truncation and are ordered for the
   tile; which of them are nearer than a light is decided lane by lane. */
static void sfield__chain_products(sfield__tile *t, sfield_cache *cache)
{
    const sfield_scene *s = t->s;
    const uint32_t n = t->count, slots = t->lights + (uint32_t)t->sky, chains = (uint32_t)t->chains;
    const size_t size = chains * (size_t)s->coefs * SFIELD__LANES, tile = t->first / SFIELD__LANES;
    uint32_t step = n + 1, from = 0, last = 0, least = n;
    uint32_t i, j, a, b;
    float *now = t->start;
    for (j = 0; j < slots; j++) {
        if (!t->needed[j]) continue;
        least = t->prefix[j] < least ? t->prefix[j] : least;
        for (i = n; i-- > last;)
            if (t->mask[(size_t)j * s->occluder_count + i]) last = i + 1;
    }
#ifndef SFIELD_WITHOUT_CACHE
    if (cache) {
        step = s->occluder_count / ((cache->lights < 255 ? cache->lights : 255) + 1) + 1;
        if (cache->lit[tile] != t->occluders_hash) cache->marks[tile] = 0;
        cache->lit[tile] = t->occluders_hash;
        from = least / step < cache->marks[tile] ? least / step : cache->marks[tile];
        if (from) sfield__recall_tile(cache, sfield__mark_slot(cache, tile, from), now, chains, s->simd);
        from *= step;
    }
#else
    (void)cache, (void)tile, (void)step, (void)least, (void)chains;
#endif
    if (!from) sfield__start_tile(t);
    for (i = from; i < last; i++) sfield__fetch_occluder(t, t->order[i]);
    for (i = from; i <= last; i++) {
#ifndef SFIELD_WITHOUT_CACHE
        /* T is rounded even if nothing starts here, so that a later start from here is the same. */
        if (i > from && i % step == 0) {
            const size_t slot = sfield__mark_slot(cache, tile, i / step);
            sfield__keep_tile(cache, slot, now, chains);
            sfield__recall_tile(cache, slot, now, chains, s->simd);
            if (cache->marks[tile] < i / step) cache->marks[tile] = (uint8_t)(i / step);
        }
#endif
        for (j = 0; j < slots; j++) {
            const uint16_t *mask = t->mask + (size_t)j * s->occluder_count;
            float *light = t->t + j * size;
            if (!t->needed[j]) continue;
            a = t->prefix[j] < last ? t->prefix[j] : last;
            if (a != i) continue;
            for (b = last; b > a && !mask[b - 1]; b--) { }
#ifndef SFIELD_WITHOUT_ROOMS
            if (sfield__is_home(s, t->set, j)) {
                sfield__chain_at_home(t, mask, b, light);
                continue;
            }
#endif
            memcpy(light, now, size * sizeof *light);
            for (; a < b; a++) sfield__apply_occluder(t, t->order[a], mask[a], light);
        }
        if (i < last) sfield__apply_occluder(t, t->order[i], t->used[t->order[i]], now);
    }
}

/* Shades 16 points by logarithms: for each light they are added up, which costs one exponential and one
   product. */
static void sfield__chain_logarithms(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    uint32_t n = s->coefs * SFIELD__LANES, slots = t->lights + (uint32_t)t->sky, i;
    uint32_t j, k, l;
    size_t size = (size_t)t->chains * n;
    float *sum = t->turned;
    int c;
    sfield__start_tile(t);
    for (i = 0; i < t->count; i++) sfield__fetch_occluder(t, t->order[i]);
    for (j = 0; j < slots; j++) {
        if (!t->needed[j]) continue;
        memset(sum, 0, n * sizeof *sum);
        for (i = 0; i < t->count; i++) {
            uint32_t mask = t->mask[(size_t)j * s->occluder_count + i];
            const float *o = t->occlusion + (size_t)t->order[i] * n;
            if (t->state[t->order[i]] == SFIELD__ALL_HIDDEN || !mask) continue;
            for (k = 0; k < n; k += SFIELD__LANES)
                for (l = 0; l < SFIELD__LANES; l++) sum[k + l] += mask >> l & 1 ? o[k + l] : 0.0f;
        }
        sfield__exponentiate16(s->algebra, sum, sum);
        t->stats.products += sfield__popcount(t->active);
        for (c = 0; c < t->chains; c++)
            sfield__product16(s->algebra, t->start + (size_t)c * n, sum, t->t + j * size + (size_t)c * n,
                              SFIELD__LANES, 0);
    }
}

/* Writes the results of the last frame again if nothing touched the tile since. Returns 1 if it did so. */
static int sfield__repeat_tile(sfield__tile *t, uint32_t in_view)
{
    const size_t unit = t->first / SFIELD__LANES;
    uint64_t points, lights;
    if (!sfield__is_untouched(t->s, t->set, t->set_hash, unit, in_view)) return 0;
    points = sfield__repeat_results(t->set, unit, t->first, t->lanes, in_view);
    lights = points * sfield__lights_of(t->s, t->set, t->sky);
    t->stats.points += points;
    t->stats.lights += lights;
    t->stats.reused += lights;
    return 1;
}

/* Keeps the results that were written, for the next frame. */
static void sfield__keep_tile_results(const sfield__tile *t, uint32_t in_view)
{
    sfield__last now;
    memset(&now, 0, sizeof now);
    now.seen = sfield__hash(t->set_hash, t->s->now_hash);
    memcpy(now.middle, t->middle, sizeof now.middle);
    now.extent = t->extent;
    now.in_view = in_view;
    now.active = t->active;
    sfield__keep_results(t->set, t->first / SFIELD__LANES, t->first, t->lanes, &now);
}

#ifndef SFIELD_WITHOUT_CACHE
/* Asks for the memory in which a cache keeps T of the tile. The memory arrives while occluders are looked
   through. */
static void sfield__fetch_kept(const sfield__tile *t, const sfield_cache *cache)
{
    const size_t values = (size_t)cache->lights * cache->chains * t->s->coefs;
    const char *kept = (const char *)(cache->value + t->first * values);
    const size_t bytes = 2 * SFIELD__LANES * values;
    size_t i;
    for (i = 0; i < bytes && i < 8192; i += 64) SFIELD__PREFETCH(kept + i);
}

/* Keeps T of those lights for which it was computed, and takes T of all lights from the cache: new ones too,
   so that they are rounded like those that were kept. */
static void sfield__exchange_kept(sfield__tile *t, sfield_cache *cache, uint32_t slots)
{
    const uint32_t chains = (uint32_t)t->chains;
    const size_t size = chains * (size_t)t->s->coefs * SFIELD__LANES;
    uint32_t j;
    for (j = 0; j < slots && j < cache->lights; j++) {
        const size_t slot = t->first / SFIELD__LANES * cache->lights + j;
        if (sfield__is_own(t, j)) continue;
        if (t->needed[j]) {
            sfield__keep_tile(cache, slot, t->t + j * size, chains);
            cache->hash[slot] = t->hash[j];
        }
        sfield__recall_tile(cache, slot, t->t + j * size, chains, t->s->simd);
    }
}
#endif

/* Finds the lights whose T has to be computed: no cache keeps it, or an old one. Returns how many. */
static uint32_t sfield__find_needed(sfield__tile *t, const sfield_cache *cache, uint32_t slots)
{
    uint32_t j, needed = 0;
    for (j = 0; j < slots; j++) {
        const size_t slot = t->first / SFIELD__LANES * (cache ? cache->lights : 0) + j;
        t->needed[j] = 0;
        if (sfield__is_own(t, j)) continue;
        t->needed[j] = !cache || j >= cache->lights || cache->hash[slot] != t->hash[j];
        needed += t->needed[j];
        if (!t->needed[j]) t->stats.reused += sfield__popcount(t->in_view);
    }
    return needed;
}

/* Shades sixteen points and writes their results. */
static void sfield__shade_tile(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    const uint32_t slots = t->lights + (uint32_t)t->sky;
    const size_t size = (size_t)t->chains * s->coefs * SFIELD__LANES;
    sfield_cache *cache = t->set->cache;
#ifndef SFIELD_WITHOUT_CACHE
    const uint32_t in_view = cache ? sfield__bits_in_view(t->set, t->first, t->lanes) : 0;
    if (cache && sfield__repeat_tile(t, in_view)) return;
#endif
    sfield__load_lanes(t);
    if (!t->in_view) {
        memset(t->t, 0, (size_t)(t->lights + 1) * size * sizeof *t->t);
        sfield__write_outputs(t);
        return;
    }
#ifndef SFIELD_WITHOUT_CACHE
    if (cache) sfield__fetch_kept(t, cache);
#endif
    t->stats.points += sfield__popcount(t->in_view);
    t->stats.lights += (uint64_t)sfield__popcount(t->in_view) * sfield__lights_of(s, t->set, t->sky);
    sfield__find_candidates(t);
    sfield__find_masks(t);
    if (sfield__find_needed(t, cache, slots)) {
        sfield__fade_candidates(t);
#ifndef SFIELD_WITHOUT_LOGARITHMS
        if (s->desc.product == SFIELD_PRODUCT_EXP) sfield__chain_logarithms(t);
        else
#endif
        sfield__chain_products(t, cache);
    }
#ifndef SFIELD_WITHOUT_CACHE
    if (cache) sfield__exchange_kept(t, cache, slots);
#endif
    sfield__write_outputs(t);
#ifndef SFIELD_WITHOUT_CACHE
    if (cache) sfield__keep_tile_results(t, in_view);
#endif
}

/* Returns whether the order leaves light j out: it is the points' own, or lies in a room. */
static int sfield__is_alone(const sfield__tile *t, uint32_t j)
{
#ifndef SFIELD_WITHOUT_ROOMS
    uint32_t i;
    for (i = 0; i < t->s->held_count; i++)
        if (t->s->held[i].light == j) return 1;
#endif
    return sfield__is_own(t, j);
}

/* Returns the lanes for which light j lies just before occluder i - 1 of the order; i = 0: before all. */
static uint32_t sfield__find_lanes_behind(const sfield__tile *t, uint32_t j, uint32_t i)
{
    const uint16_t *mask = t->mask + (size_t)j * t->s->occluder_count;
    uint32_t lanes = 0, l, k;
    for (l = 0; l < SFIELD__LANES; l++) {
        for (k = t->count; k > 0 && !(mask[k - 1] >> l & 1); k--) { }
        lanes |= (uint32_t)(k == i) << l;
    }
    return lanes;
}

/* Adds the radiance of light j to sum, for some lanes, three channels of planes. */
static void sfield__add_radiance(const sfield__tile *t, uint32_t j, uint32_t lanes, float *sum)
{
    const sfield_scene *s = t->s;
    const sfield__item *it = &s->item[s->light[j]];
    const sfield_field *f = it->e.source;
    const uint32_t n = s->coefs * SFIELD__LANES;
    float *planes = t->planes, *rows = t->rows, local[48];
    uint32_t c, k, l;
    sfield__place at;
    sfield__move_to_local(it, 1, t->p, local, s->simd);
    sfield__locate16(f, local, &at, s->simd);
    for (l = 0; l < SFIELD__LANES; l++)
        sfield__fetch_lane(f, &at, (int)l, it->e.time, f->h.stride, rows + l * f->h.stride, s->simd);
    for (c = 0; c < 3; c++) {
        for (k = 0; k < n; k++) {
            l = k % SFIELD__LANES;
            planes[k] = lanes >> l & 1
                            ? it->e.tint[c] * rows[l * f->h.stride + c * s->planes + k / SFIELD__LANES]
                            : 0.0f;
        }
        if (!it->identity)
            sfield__rotate16(&s->rotation[s->light[j]], planes, planes, SFIELD__LANES, 0, s->simd);
        for (k = 0; k < n; k++) sum[c * n + k] += planes[k];
    }
}

#ifndef SFIELD_WITHOUT_ROOMS
/* Adds the radiance of light j, which lies in a room. From inside no wall hides it and from outside all do,
   so that it has no one place in the order: what hides it is taken by itself. */
static void sfield__add_tenant(sfield__tile *t, uint32_t j, float *sum)
{
    const sfield_scene *s = t->s;
    const uint32_t n = s->coefs * SFIELD__LANES;
    const uint16_t *mask = t->mask + (size_t)j * s->occluder_count;
    float *own = sum + 3 * n;
    uint32_t i, k, c;
    memset(own, 0, 3 * n * sizeof *own);
    sfield__add_radiance(t, j, t->active, own);
    for (i = t->count; i-- > 0;) {
        const uint32_t o = t->order[i];
        const float *occlusion = t->occlusion + (size_t)o * n;
        if (!mask[i] || t->state[o] == SFIELD__ALL_HIDDEN) continue;
        if (mask[i] != t->used[o]) {
            sfield__select16(occlusion, n, mask[i], t->turned, s->simd);
            occlusion = t->turned;
        }
        t->stats.products += 3 * sfield__popcount(mask[i]);
        for (c = 0; c < 3; c++)
            sfield__product16(s->algebra, own + c * n, occlusion, own + c * n, SFIELD__LANES, 1);
    }
    for (k = 0; k < 3 * n; k++) sum[k] += own[k];
}
#endif

/* Computes the radiance that arrives at 16 points, three channels, from far to near (section 3.2 of the
   paper). Each occluder hides part of the radiance so far, and each light joins it. Lanes may disagree about
   the order of a light and an occluder, so the order is made lane by lane. */
static void sfield__shade_incident(sfield__tile *t, float *out)
{
    const sfield_scene *s = t->s;
    const uint32_t n = s->coefs * SFIELD__LANES;
    float *sum = t->t;
    uint32_t i, j, k;
    uint32_t l, c;
    sfield__load_lanes(t);
    sfield__find_candidates(t);
    sfield__find_masks(t);
    sfield__fade_candidates(t);
    for (i = 0; i < t->count; i++) sfield__fetch_occluder(t, t->order[i]);
    for (c = 0; c < 3; c++)
        for (k = 0; k < n; k++)
            sum[c * n + k] = s->has_sky || s->has_sun ? s->sky_now[c * s->planes + k / SFIELD__LANES] : 0.0f;
    for (i = t->count + 1; i-- > 0;) {
        for (j = 0; j < t->lights; j++) {
            const uint32_t lanes = sfield__is_alone(t, j) ? 0 : sfield__find_lanes_behind(t, j, i);
            if (lanes & t->active) sfield__add_radiance(t, j, lanes, sum);
        }
        if (i == 0 || t->state[t->order[i - 1]] == SFIELD__ALL_HIDDEN) continue;
        t->stats.products += 3 * sfield__popcount(t->active);
        for (c = 0; c < 3; c++)
            sfield__product16(s->algebra, sum + c * n, t->occlusion + (size_t)t->order[i - 1] * n,
                              sum + c * n, SFIELD__LANES, 1);
    }
#ifndef SFIELD_WITHOUT_ROOMS
    for (j = 0; j < t->lights; j++)
        if (!sfield__is_own(t, j) && sfield__is_alone(t, j)) sfield__add_tenant(t, j, sum);
#endif
    for (l = 0; l < t->lanes; l++)
        for (k = 0; k < 3 * s->coefs; k++)
            out[(t->first + l) * 3 * s->coefs + k] =
                t->in_view >> l & 1 ? sum[k * SFIELD__LANES + l] : 0.0f;
}

typedef struct sfield__job {
    sfield_scene        *s;
    const sfield_points *sets;
    size_t               set_count;
    size_t               scratch;               /* bytes a task */
    uint32_t             pieces;
    float               *incident;
    sfield_scene_stats   stats[SFIELD__PIECES];
} sfield__job;

/* ==== src/shadowfield/wavelets_visibility.h ==== */

/* ---- wavelets: the texels of a point times the visibility of an occluder ---- */

typedef struct sfield__ray {
    float d2;
    uint32_t item;
    int light;
} sfield__ray; /* light: the number of a light; -1: the item is an occluder */

typedef struct sfield__point {
    const sfield_scene *s;
    const sfield_points *set;
    float       *t, *haar, *coefs, *work;       /* 6 N^2, 6 N^2, 3 x 6 N^2, 6 N^2 */
    uint8_t     *marks;                         /* six faces of SFIELD__MARKS */
    sfield__ray *ray;
    float       *rgb;                           /* of one point */
#ifndef SFIELD_WITHOUT_GLOSS
    float       *kernels;                       /* with gloss: 3 x 6 N^2, BRDFs on texels */
    const float *kernel;                        /* the one that T begins with; NULL: the cosine */
#endif
#ifndef SFIELD_WITHOUT_ROOMS
    const sfield_points *own;                    /* the set; the walk of lights in the own room, `home`, has a
                                                    copy without self-visibility */
    int          home;
#endif
    uint64_t     all_hash, set_hash;             /* sfield__hash_set; and sfield__hash_brdfs of a point */
    uint32_t     chain, chains;                  /* T of the moment, of so many */
    sfield_scene_stats stats;
} sfield__point;

/* Divides memory among the arrays of a point. kernels: how many planes of texels BRDFs need. */
static size_t sfield__carve_point(sfield__point *p, uint8_t *memory, uint32_t rays, uint32_t cells,
                                  uint32_t kernels)
{
    size_t floats = (6 + kernels) * (size_t)cells;
    if (memory) {
#ifndef SFIELD_WITHOUT_GLOSS
        p->kernels = (float *)(void *)memory + 6 * (size_t)cells;
#endif
        p->t = (float *)(void *)memory;
        p->haar = p->t + cells;
        p->coefs = p->haar + cells;
        p->work = p->coefs + 3 * (size_t)cells;
        p->ray = (sfield__ray *)(void *)(p->t + floats);
        p->marks = (uint8_t *)(p->ray + rays + 1);
        memset(p->coefs, 0, 3 * (size_t)cells * sizeof *p->coefs);
        memset(p->marks, 0, 6 * SFIELD__MARKS);
    }
    return (floats * sizeof(float) + (rays + 1) * sizeof(sfield__ray) + 6 * SFIELD__MARKS + 63) / 64 * 64;
}

/* Multiplies the texels of each face by 1 - the function in p->coefs. */
static void sfield__shade_faces(const sfield__point *p)
{
    const uint32_t side = p->s->side, n = side * side;
    uint32_t face;
    for (face = 0; face < 6; face++)
        sfield__darken16(p->coefs + face * n, p->marks + face * SFIELD__MARKS, side, p->t + face * n,
                         p->s->simd);
}

/* Adds the lists of an occluder up in p->coefs, which is clean before, and marks the squares that they use
   and all above these. Square k of all levels in turn lies in square (k - 1) / 4. sfield__clear_lists cleans
   up. */
static void sfield__add_lists(sfield__point *p, const sfield_field *f, const sfield__lists *lists,
                              float factor)
{
    uint32_t i, bits = 0;
    while (1u << bits < p->s->side * p->s->side) bits++;
    for (i = 0; i < lists->count; i++) {
        const float weight = lists->weight[i] * factor * f->sample_scale[lists->sample[i]];
        const uint32_t *e = f->entry + f->offset[lists->sample[i]],
                       *end = f->entry + f->offset[lists->sample[i] + 1];
        for (; e < end; e++) {
            const uint32_t index = *e >> 16, in_face = index & ((1u << bits) - 1);
            uint8_t *marks = p->marks + (index >> bits) * SFIELD__MARKS;
            uint32_t square = (in_face - 1) / 3;
            p->coefs[index] += weight * sfield__signed_short(*e);
            if (!in_face) continue;
            for (; !marks[square]; square = (square - 1) / 4) {
                marks[square] = 1;
                if (!square) break;
            }
        }
    }
}

static void sfield__clear_lists(sfield__point *p)
{
    const uint32_t used = sfield__mark_base(p->s->side * p->s->side);
    uint32_t face;
    memset(p->coefs, 0, p->s->cells * sizeof *p->coefs);
    for (face = 0; face < 6; face++) memset(p->marks + face * SFIELD__MARKS, 0, used);
}

/* Multiplies T by the visibility in p->coefs: expanded only where it has detail; rotated entities texel by
   texel. */
static void sfield__hide_texels(sfield__point *p, uint32_t map)
{
    const sfield_scene *s = p->s;
    uint32_t i;
    if (map) {
        const sfield__taps *taps = s->taps + (size_t)(map - 1) * s->cells;
        sfield__haar_texels(s->side, p->coefs, p->work);
        for (i = 0; i < s->cells; i++) {
            const sfield__taps *q = taps + i;
            p->t[i] *= 1 - (q->weight[0] * p->work[q->texel[0]] + q->weight[1] * p->work[q->texel[1]] +
                            q->weight[2] * p->work[q->texel[2]] + q->weight[3] * p->work[q->texel[3]]);
        }
    } else if (s->desc.product == SFIELD_PRODUCT_SPARSE) {
        sfield__haar_multiply(s->side, p->haar, p->coefs, p->work);
        for (i = 0; i < s->cells; i++) p->haar[i] -= p->work[i];
    } else
        sfield__shade_faces(p);
}

/* ==== src/shadowfield/wavelets_rooms.h ==== */

/* ---- wavelets: lights inside of what hides ---- */

/* Takes a room behind the light that it holds. Lights that it does not hold stay behind it. The list has one
   order for all lights: these then lie behind the occluders between the room and the light that it holds,
   too. */
static void sfield__take_behind(const sfield_scene *s, sfield__ray *ray, uint32_t room, uint32_t light)
{
    const uint32_t item = ray[room].item;
    uint32_t i, first = room;           /* from here on: the room, and lights that it does not hold */
    for (i = room + 1; i <= light; i++) {
        const sfield__ray moved = ray[i];
        if (moved.light >= 0 && !sfield__is_held(s, (uint32_t)moved.light, item)) continue;
        memmove(ray + first + 1, ray + first, (i - first) * sizeof *ray);
        ray[first++] = moved;
    }
}

/* Orders rooms and the lights in them as x sees them, among the `count` entities of a point. A light that is
   seen from outside of its room goes behind all that is nearer than the room's centre; harmonics, whose masks
   are those of one light each, hide it by the room alone. */
static void sfield__order_rooms(const sfield__point *p, const float *x, uint32_t count)
{
    const sfield_scene *s = p->s;
    sfield__ray *ray = p->ray;
    uint32_t i, room, light;
    for (i = 0; i < s->held_count; i++) {
        const struct sfield__tenant *held = &s->held[i];
        for (room = 0; room < count && (ray[room].light >= 0 || ray[room].item != held->item);) room++;
        for (light = 0; light < count && ray[light].light != (int)held->light;) light++;
        if (room == count || light == count) continue;
        if (sfield__is_in_hull(&s->item[held->item], x, s->simd)) {
            if (room < light) sfield__take_behind(s, ray, room, light);
        } else if (light < room) {
            const sfield__ray moved = ray[light];
            memmove(ray + light, ray + light + 1, (room - light) * sizeof *ray);
            ray[room] = moved;
        }
    }
}

/* Returns whether points have a self-visibility and lie on an object that is a room for some light. */
static int sfield__has_home(const sfield_scene *s, const sfield_points *set)
{
    return set->entity && set->self && s->item[set->entity - 1].holds;
}

/* ==== src/shadowfield/wavelets_point.h ==== */

/* ---- wavelets: one point, from near to far ---- */

static void sfield__find_lists_of(const sfield__item *it, int which, const float *x, float time, int simd,
                             sfield__lists *lists)
{
    const sfield_field *f = which ? it->e.source : it->e.occlusion;
    float p[48] = { 0 }, local[48];
    sfield__place at;
    uint32_t k;
    for (k = 0; k < 3; k++) p[16 * k] = x[k];
    sfield__move_to_local(it, which, p, local, simd);
    sfield__locate16(f, local, &at, simd);
    sfield__find_lists(f, &at, 0, time, lists);
}

/* Puts an occluder in reach and above the horizon, or a light, among the `count` entities of a point, from
   near to far; equally far ones in the order of the scene, a light before the occluder that it also is.
   Returns how many there are. */
static uint32_t sfield__add_ray(sfield__point *p, const float *x, const float *n, uint32_t item, int light,
                                uint32_t count)
{
    const sfield__item *it = &p->s->item[item];
    const float *c = it->center[light >= 0];
    sfield__ray *r = p->ray, *to = r + count;
    float d[3], d2;
    if (item + 1 == p->set->entity) return count;           /* neither hides nor lights its own points */
    d[0] = c[0] - x[0];
    d[1] = c[1] - x[1];
    d[2] = c[2] - x[2];
    d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    if (light < 0) {
        if (!(d2 < it->reach * it->reach)) return count;
        p->stats.culled_far--;
        if (d[0] * n[0] + d[1] * n[1] + d[2] * n[2] <= -it->radius[0]) {
            p->stats.culled_horizon++;
            return count;
        }
    }
    for (; to > r && (to[-1].d2 > d2 || (!(to[-1].d2 < d2) && to[-1].item > item)); to--) *to = to[-1];
    to->d2 = d2;
    to->item = item;
    to->light = light;
    return count + 1;
}

/* Lists the entities of a point, occluders and lights, from near to far. Returns how many there are. */
static uint32_t sfield__find_rays(sfield__point *p, const float *x, const float *n)
{
    const sfield_scene *s = p->s;
    const uint32_t others = s->occluder_count - sfield__is_on_occluder(s, p->set);
    uint32_t i, count = 0;
#ifndef SFIELD_WITHOUT_HIERARCHY
    sfield__walk w;
#endif
    p->stats.pairs += others;
    p->stats.culled_far += others;
    for (i = 0; i < s->light_count; i++) count = sfield__add_ray(p, x, n, s->light[i], (int)i, count);
#ifdef SFIELD_WITHOUT_HIERARCHY
    for (i = 0; i < s->occluder_count; i++) count = sfield__add_ray(p, x, n, s->occluder[i], -1, count);
#else
    sfield__start_walk(&w, s, x, 0);
    while ((i = sfield__next_near(&w)) != SFIELD__NONE) count = sfield__add_ray(p, x, n, i, -1, count);
#endif
#ifndef SFIELD_WITHOUT_ROOMS
    if (s->held_count) sfield__order_rooms(p, x, count);
#endif
    return count;
}

/* Returns whether ray i is hidden by the second rule of culling, as tiles have it: rays [0, i) are nearer. */
static int sfield__is_hidden(const sfield__point *p, uint32_t i, const float *x)
{
    const sfield__item *a = &p->s->item[p->ray[i].item];
    const int which = p->ray[i].light >= 0;
    float d2 = p->ray[i].d2, sin_a = a->radius[which] / sqrtf(d2), cos_a;
    uint32_t j, k;
    if (!(sin_a < 1)) return 0;
    cos_a = sqrtf(1 - sin_a * sin_a);
    for (j = 0; j < i; j++) {
        const sfield__item *b = &p->s->item[p->ray[j].item];
        float e2 = p->ray[j].d2, sin_b, dot = 0;
        if (p->ray[j].light >= 0 || !(b->inscribed > 0) || b->inscribed * b->inscribed >= e2 || b == a)
            continue;
        if (e2 > 0.5625f * b->reach * b->reach) continue;
        sin_b = b->inscribed / sqrtf(e2);
        if (sin_b <= sin_a) continue;
        for (k = 0; k < 3; k++) dot += (a->center[which][k] - x[k]) * (b->center[0][k] - x[k]);
        if (dot >= (cos_a * sqrtf(1 - sin_b * sin_b) + sin_a * sin_b) * sqrtf(d2 * e2)) return 1;
    }
    return 0;
}

/* Computes T = BRDF x max(0, cos) x solid angle x visibility of the own object, on texels. */
static void sfield__start_texels(sfield__point *p, size_t index, const float *n)
{
    const sfield_scene *s = p->s;
#ifndef SFIELD_WITHOUT_GLOSS
    if (p->kernel) memcpy(p->t, p->kernel, s->cells * sizeof *p->t);
    else
#endif
        sfield__fill_cosines16(s->texel, s->cells, n, p->t, s->simd);
    if (p->set->self) {
        sfield__lists own;
        const int sparse = s->desc.product == SFIELD_PRODUCT_SPARSE;
        uint32_t map = p->set->entity ? s->item[p->set->entity - 1].map : 0;
        own.count = 1;
        own.sample[0] = index;
        own.weight[0] = 1;
        if (sparse) sfield__haar_cube(s->side, p->t, p->haar, s->simd);
        sfield__add_lists(p, p->set->self, &own, 1);
        sfield__hide_texels(p, map);
        sfield__clear_lists(p);
    } else if (s->desc.product == SFIELD_PRODUCT_SPARSE) sfield__haar_cube(s->side, p->t, p->haar, s->simd);
}

/* Adds what a light's lists make of T in wavelets (of rotated lights: of T on texels). */
static void sfield__add_light(sfield__point *p, const sfield__item *it, const float *x, const float *haar)
{
    const sfield_scene *s = p->s;
    const sfield_field *f = it->e.source;
    const uint32_t cells = s->cells;
    sfield__lists lists;
    float rgb[3] = { 0, 0, 0 };
    uint32_t i, k, c;
    sfield__find_lists_of(it, 1, x, it->e.time, s->simd, &lists);
    if (!it->map) {
        for (i = 0; i < lists.count; i++) {
            float w = lists.weight[i] * f->sample_scale[lists.sample[i]];
            for (k = f->offset[lists.sample[i]]; k < f->offset[lists.sample[i] + 1]; k++) {
                const uint32_t *e = f->entry + 2 * (size_t)k;
                float t = w * haar[e[0] >> 16];
                rgb[0] += t * sfield__signed_short(e[0]);
                rgb[1] += t * sfield__signed_short(e[1] >> 16);
                rgb[2] += t * sfield__signed_short(e[1]);
            }
        }
    } else {
        const sfield__taps *taps = s->taps + (size_t)(it->map - 1) * cells;
        for (i = 0; i < lists.count; i++) sfield__scatter_list(f, lists.sample[i], lists.weight[i], p->coefs);
        for (c = 0; c < 3; c++) {
            sfield__haar_texels(s->side, p->coefs + c * cells, p->work);
            for (i = 0; i < cells; i++)
                for (k = 0; k < 4 && p->t[i] != 0; k++)
                    rgb[c] += p->t[i] * taps[i].weight[k] * p->work[taps[i].texel[k]];
        }
        memset(p->coefs, 0, 3 * (size_t)cells * sizeof *p->coefs);
    }
    for (c = 0; c < 3; c++) p->rgb[c] += it->e.tint[c] * rgb[c];
}

/* Keeps the largest wavelets of T in the cache, by the measure that fields are cut with. */
static void sfield__keep_wavelets(sfield__point *p, sfield_cache *c, size_t slot)
{
    const uint32_t cells = p->s->cells, side = p->s->side;
    uint16_t *index = c->index + slot * SFIELD__CACHED;
    int16_t *value = c->value + slot * SFIELD__CACHED;
    float threshold = 0, most = 0, inverse, weight = 0;
    uint32_t i, n = 0, used = 0, equal = SFIELD__CACHED;
    uint32_t next = 0, face = side * side;
    float *key = p->work, *sorted = p->coefs;   /* clean again below */
    for (i = 0; i < cells; i++) {
        uint32_t in_face = i & (face - 1);
        if (in_face == 0 || in_face == next) {      /* the next finer level */
            weight = in_face ? 0.5f * weight : (float)side;
            next = in_face ? 4 * next : 4;
        }
        key[i] = fabsf(p->haar[i]) * weight;
        if (key[i] > 0) sorted[used++] = key[i];
    }
    if (used > SFIELD__CACHED) threshold = sfield__select_rank(sorted, used, SFIELD__CACHED - 1);
    memset(sorted, 0, used * sizeof *sorted);
    /* those that lie at the threshold have the places that are left: mirrored lobes have many of one size */
    for (i = 0; i < cells; i++) equal -= key[i] > threshold;
    for (i = 0; i < cells; i++)
        if (key[i] > 0 && (key[i] > threshold || (key[i] == threshold && equal && equal--))) {
            index[n++] = (uint16_t)i;
            most = fabsf(p->haar[i]) > most ? fabsf(p->haar[i]) : most;
        }
    c->scale[slot] = sfield__scale_of(most);
    inverse = most > SFIELD__LEAST_T ? 32767 / most : 0;
    for (i = 0; i < SFIELD__CACHED; i++) {
        value[i] = i < n ? sfield__to_int16(p->haar[index[i]] * inverse) : (int16_t)0;
        if (i >= n) index[i] = 0;
    }
}

/* Adds light from the cache: a few wavelets of T times the sky's, once for each T and sky, or unpacked for
   the lists of lights. */
static void sfield__light_from_cache(sfield__point *p, const sfield_cache *c, size_t slot,
                                     const sfield__item *it, const float *x)
{
    const uint16_t *index = c->index + slot * SFIELD__CACHED;
    const int16_t *value = c->value + slot * SFIELD__CACHED;
    const uint32_t cells = p->s->cells;
    uint32_t i, k;
    if (!it) {
        const size_t own = slot / c->chains / c->lights * c->chains + p->chain;
        const uint64_t now = sfield__hash(c->hash[slot], p->s->sky_hash) | 1;
        uint64_t *lit = &c->lit[own];
        float *rgb = c->sky + 3 * own;
        for (k = 0; k < 3 && *lit != now; k++) {
            const float *sky = p->s->sky_now + (3 + k) * cells;
            rgb[k] = 0;
            for (i = 0; i < SFIELD__CACHED; i++) rgb[k] += (float)value[i] * sky[index[i]];
            rgb[k] *= c->scale[slot];
        }
        *lit = now;
        for (k = 0; k < 3; k++) p->rgb[k] += rgb[k];
        return;
    }
    if (it->map) {
        memset(p->haar, 0, cells * sizeof *p->haar);
        for (i = 0; i < SFIELD__CACHED; i++) p->haar[index[i]] += (float)value[i] * c->scale[slot];
        sfield__haar_texels(p->s->side, p->haar, p->t);
        sfield__add_light(p, it, x, NULL);
        return;
    }
    for (i = 0; i < SFIELD__CACHED; i++) p->coefs[index[i]] += (float)value[i] * c->scale[slot];
    sfield__add_light(p, it, x, p->coefs);
    for (i = 0; i < SFIELD__CACHED; i++) p->coefs[index[i]] = 0;
}

static void sfield__add_sky(sfield__point *p)
{
    const sfield_scene *s = p->s;
    const int sparse = s->desc.product == SFIELD_PRODUCT_SPARSE;
    const float *sky = s->sky_now + (sparse ? 3u : 0u) * s->cells, *t = sparse ? p->haar : p->t;
    float sum[32];
    uint32_t c, k;
    sfield__dot_sky16(sky, t, s->cells, sum, s->simd);
    for (c = 0; c < 3; c++)
        for (k = 0; k < 8; k++) p->rgb[c] += sum[8 * c + k];
}

/* Returns whether a cache keeps T for a light. */
static int sfield__keeps_light(const sfield_cache *c, uint32_t slot) { return c && slot < c->lights; }

/* Returns where a cache keeps the T of the moment for a light of point `index`. */
static size_t sfield__slot_of(const sfield__point *p, size_t index, uint32_t light)
{
    const sfield_cache *c = p->set->cache;
    return (index * c->lights + light) * c->chains + p->chain;
}

/* Goes through the first rays of figure 5 on texels (or on coefficients). Lights that a cache keeps T for are
   not added here, but later from what was kept; only those whose T is out of date are kept anew. */
static void sfield__walk_rays(sfield__point *p, size_t index, const float *x, const float *n, uint32_t count,
                              const uint64_t *hash, uint32_t until, float *ambient)
{
    const sfield_scene *s = p->s;
    sfield_cache *cache = p->set->cache;
    const int sparse = s->desc.product == SFIELD_PRODUCT_SPARSE;
    uint32_t i, k;
    int fresh = 0;                              /* p->haar is that of p->t */
    sfield__start_texels(p, index, n);
    for (i = 0; i < until; i++) {
        const sfield__item *it = i < count ? &s->item[p->ray[i].item] : NULL;
        const uint32_t slot = it ? (uint32_t)p->ray[i].light : s->light_count;
        uint64_t *kept;
        if (it && p->ray[i].light < 0) {
            sfield__lists lists;
            float fade = 4 * (1 - sqrtf(p->ray[i].d2) / it->reach);
            if (sfield__is_hidden(p, i, x)) {
                p->stats.culled_hidden++;
                continue;
            }
            sfield__find_lists_of(it, 0, x, 0, s->simd, &lists);
            sfield__add_lists(p, it->e.occlusion, &lists, fade < 1 ? fade : 1);
            sfield__hide_texels(p, it->map);
            sfield__clear_lists(p);
            p->stats.products++;
            fresh = 0;
            continue;
        }
#ifndef SFIELD_WITHOUT_ROOMS
        if (sfield__is_home(s, p->own, slot) != p->home) continue;
#endif
        kept = sfield__keeps_light(cache, slot) ? &cache->hash[sfield__slot_of(p, index, slot)] : NULL;
        if (kept && *kept == hash[slot]) continue;
        if (!fresh && !sparse && (kept || (it && !it->map))) {
            sfield__haar_cube(s->side, p->t, p->haar, s->simd);
            fresh = 1;
        }
        if (kept) {
            sfield__keep_wavelets(p, cache, sfield__slot_of(p, index, slot));
            *kept = hash[slot];
        } else if (it) sfield__add_light(p, it, x, p->haar);
        else if (s->has_sky || s->has_sun) sfield__add_sky(p);
    }
    if (ambient) {
        float sum = 0;
        if (sparse) sfield__haar_texels(s->side, p->haar, p->t);
        for (k = 0; k < s->cells; k++) sum += p->t[k];
        *ambient = sum * 0.318309886f;
    }
}

/* Writes the hash of all that T of each light depends on, which is the occluders nearer than the light; 0 for
   lights that are not asked for. Returns how many rays have to be walked, the environment as the last: up to
   the last light whose T is not kept, or is out of date. */
static uint32_t sfield__find_stale(sfield__point *p, size_t index, uint32_t count, uint64_t *hash)
{
    const sfield_scene *s = p->s;
    const sfield_cache *cache = p->set->cache;
    const int sky = s->has_sky || s->has_sun;
    uint64_t before = p->set_hash;
    uint32_t i, until = 0;
    for (i = 0; i <= s->light_count; i++) hash[i] = 0;
    for (i = 0; i <= count; i++) {
        const uint32_t slot = i < count ? (uint32_t)p->ray[i].light : s->light_count;
        if (i < count && p->ray[i].light < 0) {
            before = sfield__hash(before, s->item[p->ray[i].item].body);
            continue;
        }
        if (i == count && !sky && !p->set->ambient) continue;
#ifndef SFIELD_WITHOUT_ROOMS
        hash[slot] = (sfield__is_home(s, p->set, slot) ? sfield__hash(before, 1) : before) | 1;
#else
        hash[slot] = before | 1;
#endif
        if (sfield__keeps_light(cache, slot) && cache->hash[sfield__slot_of(p, index, slot)] == hash[slot])
            p->stats.reused += i < count || sky;
        else
            until = i + 1;
    }
    return until;
}

/* Returns the light of a sky of 1 by the T that is kept for the environment: sums of whole faces. */
static float sfield__ambient_from_cache(const sfield_scene *s, const sfield_cache *c, size_t slot)
{
    float sum = 0;
    size_t i, at = slot * SFIELD__CACHED;
    for (i = at; i < at + SFIELD__CACHED; i++)
        if (c->index[i] % (s->side * s->side) == 0)
            sum += (float)c->value[i] * c->scale[slot] * (float)s->side * 0.318309886f;
    return sum;
}

/* Computes light by the T of the moment, once rays and what is stale are known: writes p->rgb, and *ambient
   if the caller asks for it. */
static void sfield__light_chain(sfield__point *p, size_t index, const float *x, const float *n,
                                uint32_t count, uint32_t until, const uint64_t *hash, float *ambient)
{
    const sfield_scene *s = p->s;
    sfield_cache *cache = p->set->cache;
    const int kept = sfield__keeps_light(cache, s->light_count);
    uint32_t j;
#ifndef SFIELD_WITHOUT_ROOMS
    p->own = p->set;
    if (until && sfield__has_home(s, p->set)) {     /* lights of the room, without its self-visibility */
        sfield_points bare = *p->own;
        bare.self = NULL;
        p->set = &bare;
        p->home = 1;
        sfield__walk_rays(p, index, x, n, count, hash, until, NULL);
        p->set = p->own;
        p->home = 0;
    }
#endif
    if (until) sfield__walk_rays(p, index, x, n, count, hash, until, kept ? NULL : ambient);
    for (j = 0; cache && j <= s->light_count && j < cache->lights; j++)
        if (!hash[j]) continue;                 /* the own entity's */
        else if (j < s->light_count)
            sfield__light_from_cache(p, cache, sfield__slot_of(p, index, j), &s->item[s->light[j]], x);
        else if (s->has_sky || s->has_sun)
            sfield__light_from_cache(p, cache, sfield__slot_of(p, index, j), NULL, x);
    if (ambient && kept)
        *ambient = sfield__ambient_from_cache(s, cache, sfield__slot_of(p, index, s->light_count));
}

/* Shades a point that can be shaded: writes p->rgb, and *ambient if the caller asks for it. */
static void sfield__light_point(sfield__point *p, size_t index, const float *x, const float *n,
                                uint64_t *hash, float *ambient)
{
    const uint32_t count = sfield__find_rays(p, x, n), until = sfield__find_stale(p, index, count, hash);
    sfield__light_chain(p, index, x, n, count, until, hash, ambient);
}

#ifndef SFIELD_WITHOUT_GLOSS
static SFIELD__COLD void sfield__light_gloss(sfield__point *p, const sfield__tile *one, uint64_t *hash,
                                             float *ambient);
#endif

static void sfield__shade_point(sfield__point *p, size_t index, uint64_t *hash)
{
    const sfield_scene *s = p->s;
    const sfield_points *set = p->set;
    const uint32_t lights = sfield__lights_of(s, set, s->has_sky || s->has_sun);
    sfield__tile one;                           /* a tile of one lane, since tiles load points */
    float x[3], n[3], ambient = 0, rgb[3] = { 0, 0, 0 };
    uint32_t k, in_view = sfield__bits_in_view(set, index, 1);
#ifndef SFIELD_WITHOUT_GLOSS
    if (p->chains > 1 && set->cache) p->set_hash = sfield__hash_brdfs(p->all_hash, set, index, 1);
#endif
    if (set->cache && sfield__is_untouched(s, set, p->set_hash, index, in_view)) {
        const uint32_t points = sfield__repeat_results(set, index, index, 1, in_view);
        p->stats.points += points;
        p->stats.lights += points * lights;
        p->stats.reused += points * lights;
        return;
    }
    memset(&one, 0, sizeof one);
    one.s = s;
    one.set = set;
    one.first = index;
    one.lanes = 1;
#ifndef SFIELD_WITHOUT_GLOSS
    one.chains = (int)p->chains;
#endif
    sfield__load_lanes(&one);
    for (k = 0; k < 3; k++) {
        x[k] = one.p[16 * k];
        n[k] = one.n[16 * k];
    }
    p->rgb = rgb;
    if (one.in_view) {
        p->stats.points++;
        p->stats.lights += lights;
#ifndef SFIELD_WITHOUT_GLOSS
        if (one.chains > 1) sfield__light_gloss(p, &one, hash, set->ambient ? &ambient : NULL);
        else
#endif
            sfield__light_point(p, index, x, n, hash, set->ambient ? &ambient : NULL);
    }
    p->rgb = NULL;
    for (k = 0; k < 3 && set->rgb; k++) set->rgb[3 * index + k] = rgb[k] * 0.318309886f;
    if (set->ambient) set->ambient[index] = ambient;
    if (set->cache) {
        sfield__last now;
        memset(&now, 0, sizeof now);
        now.seen = sfield__hash(p->set_hash, s->now_hash);
        memcpy(now.middle, x, sizeof now.middle);
        now.in_view = in_view;
        now.active = one.active;
        sfield__keep_results(set, index, index, 1, &now);
    }
}

/* ==== src/shadowfield/wavelets_bundle.h ==== */

/* ---- wavelets: sixteen points at a time ---- */

static size_t sfield__carve_bundle(sfield__bundle *b, uint8_t *memory, uint32_t rays, uint32_t side)
{
    const size_t strands = (rays < SFIELD__STRANDS ? rays : (uint32_t)SFIELD__STRANDS) + 1;
    const size_t plane = 16 * (size_t)side * side, lists = strands * SFIELD__STRAND_LISTS;
    if (memory) {
        b->t = (float *)(void *)memory;
        b->w = b->t + plane;
        b->list = (sfield__listing *)(void *)(b->w + plane);
        b->strand = (sfield__strand *)(void *)(b->list + lists);
        b->trial = b->strand + strands;
        b->used = (uint16_t *)(void *)(b->trial + strands);
        b->marks = (uint8_t *)(b->used + SFIELD__MARKS);
        memset(b->marks, 0, SFIELD__MARKS);
    }
    return (2 * plane * sizeof(float) + 2 * strands * sizeof(sfield__strand) +
            lists * sizeof(sfield__listing) + 3 * SFIELD__MARKS + 63) /
           64 * 64;
}

/* Puts the rays of a point among those of the bundle, from near to far. Returns 0 if they have another order,
   or are too many. */
static int sfield__weave_rays(sfield__bundle *b, const sfield__point *p, uint32_t rays, const float *x,
                         uint32_t lane, uint64_t *hidden)
{
    uint32_t i, j, at = 0, count = b->strands;
    memcpy(b->trial, b->strand, count * sizeof *b->trial);
    for (i = 0; i < rays; i++) {
        const sfield__ray *r = &p->ray[i];
        if (r->light < 0 && sfield__is_hidden(p, i, x)) {
            ++*hidden;
            continue;
        }
        for (j = 0; j < count && (b->trial[j].item != r->item || b->trial[j].light != r->light);) j++;
        if (j < at) return 0;
        if (j == count) {
            if (count == SFIELD__STRANDS) return 0;
            j = at;
            memmove(b->trial + j + 1, b->trial + j, (count++ - j) * sizeof *b->trial);
            b->trial[j].item = r->item;
            b->trial[j].light = r->light;
            b->trial[j].lanes = 0;
        }
        b->trial[j].lanes |= 1u << lane;
        b->trial[j].d2[lane] = r->d2;
        at = j + 1;
    }
    b->strands = count;
    memcpy(b->strand, b->trial, count * sizeof *b->trial);
    return 1;
}

/* Takes what is kept at a sample for one more lane. */
static void sfield__take_list(sfield__strand *strand, const sfield_field *f, size_t sample, uint32_t lane,
                              float weight)
{
    sfield__listing *l = strand->list, *end = l + strand->count;
    while (l < end && l->sample != sample) l++;
    if (l == end) {
        memset(l->weight, 0, sizeof l->weight);
        l->sample = sample;
        l->e = f->entry + (size_t)f->offset[sample] * f->h.stride;
        l->end = f->entry + (size_t)f->offset[sample + 1] * f->h.stride;
        strand->count++;
    }
    l->weight[lane] += weight;
}

/* Takes the samples around the lanes' places. Those of occluders fade over the last quarter of their
   reach. */
static void sfield__take_lists(sfield__strand *strand, const sfield__item *it, const sfield__tile *tile,
                               int simd)
{
    const int which = strand->light >= 0;
    const sfield_field *f = which ? it->e.source : it->e.occlusion;
    float local[48];
    sfield__place at;
    sfield__lists lists;
    uint32_t l, k;
    strand->count = 0;
    sfield__move_to_local(it, which, tile->p, local, simd);
    sfield__locate16(f, local, &at, simd);
    for (l = 0; l < SFIELD__LANES; l++) {
        float factor = 1;
        if (!(strand->lanes >> l & 1)) continue;
        sfield__find_lists(f, &at, (int)l, which ? it->e.time : 0.0f, &lists);
        if (!which) factor = 4 * (1 - sqrtf(strand->d2[l]) / it->reach);
        factor = factor < 1 ? factor : 1.0f;
        for (k = 0; k < lists.count; k++)
            sfield__take_list(strand, f, lists.sample[k], l, lists.weight[k] * factor);
    }
}

/* Shades the woven lanes of a tile: each by its own entities, all face by face. */
static void sfield__run_bundle(sfield__bundle *b, const sfield_points *set, const sfield__tile *tile,
                               uint32_t lanes)
{
    const sfield_scene *s = b->s;
    uint32_t i, l, face;
    if (set->self) {
        memmove(b->strand + 1, b->strand, b->strands++ * sizeof *b->strand);
        b->strand[0].light = -2;
        b->strand[0].count = 0;
    }
    for (i = 0; i < b->strands; i++) {
        sfield__strand *strand = &b->strand[i];
        strand->list = b->list + (size_t)i * SFIELD__STRAND_LISTS;
        if (strand->light >= -1) sfield__take_lists(strand, &s->item[strand->item], tile, s->simd);
        for (l = 0; strand->light < -1 && l < SFIELD__LANES; l++)
            if (lanes >> l & 1) sfield__take_list(strand, set->self, tile->first + l, l, 1);
    }
    memcpy(b->n, tile->n, sizeof b->n);
    memset(b->rgb, 0, sizeof b->rgb);
    memset(b->open, 0, sizeof b->open);
    b->ambient = set->ambient != NULL;
    for (face = 0; face < 6; face++) SFIELD__CALL_BEST(sfield__face_shade, s->simd, (b, set->self, face));
    for (l = 0; l < SFIELD__LANES; l++) {
        const size_t at = tile->first + l;
        if (!(lanes >> l & 1)) continue;
        for (i = 0; i < 3 && set->rgb; i++) set->rgb[3 * at + i] = b->rgb[16 * i + l] * 0.318309886f;
        if (set->ambient) set->ambient[at] = b->open[l] * 0.318309886f;
    }
}

/* Shades as many lanes together as have one order of their entities. One or two lanes go by themselves. */
static void sfield__shade_bundle(sfield__point *p, sfield__bundle *b, size_t first, uint32_t lanes,
                                 uint64_t *hash)
{
    const sfield_points *set = p->set;
    const uint32_t lights = sfield__lights_of(p->s, set, p->s->has_sky || p->s->has_sun);
    sfield__tile tile;
    uint32_t l, k, i, left = (1u << lanes) - 1;
    memset(&tile, 0, sizeof tile);
    tile.s = p->s;
    tile.set = set;
    tile.first = first;
    tile.lanes = lanes;
    sfield__load_lanes(&tile);
    while (left) {
        const sfield_scene_stats before = p->stats;
        uint32_t taken = 0, count = 0;
        b->strands = 0;
        for (l = 0; l < lanes; l++) {
            const sfield_scene_stats then = p->stats;
            uint64_t hidden = 0;
            float x[3], n[3];
            if (!(left & tile.in_view & 1u << l)) continue;
            for (k = 0; k < 3; k++) {
                x[k] = tile.p[16 * k + l];
                n[k] = tile.n[16 * k + l];
            }
            if (sfield__weave_rays(b, p, sfield__find_rays(p, x, n), x, l, &hidden)) {
                taken |= 1u << l;
                count++;
                p->stats.culled_hidden += hidden;
            } else if (!taken) {                /* more than a bundle takes */
                taken = 1u << l;
                break;
            } else p->stats = then;
        }
        if (count < SFIELD__FEWEST) {
            p->stats = before;
            taken = taken ? taken : left;
            for (l = 0; l < lanes; l++)
                if (taken >> l & 1) sfield__shade_point(p, first + l, hash);
        } else {
            p->stats.points += count;
            p->stats.lights += (uint64_t)count * lights;
            for (i = 0; i < b->strands; i++)
                for (l = 0; b->strand[i].light < 0 && l < lanes; l++)
                    p->stats.products += b->strand[i].lanes >> l & 1;
            sfield__run_bundle(b, set, &tile, taken);
        }
        left &= ~taken;
    }
}

/* Returns whether a set can be shaded in bundles: texels are multiplied, no cache keeps anything, and no
   entity is turned that hides, shines or has a visibility of its own. */
static int sfield__can_bundle(const sfield_scene *s, const sfield_points *set)
{
    uint32_t i;
    if (set->cache || s->desc.product == SFIELD_PRODUCT_SPARSE) return 0;
    if (set->self && set->entity && s->item[set->entity - 1].map) return 0;
#ifndef SFIELD_WITHOUT_ROOMS
    if (sfield__has_home(s, set)) return 0;
#endif
    for (i = 0; i < s->item_count; i++)
        if (s->item[i].map && (s->item[i].e.occlusion || s->item[i].e.source)) return 0;
    return 1;
}

/* ==== src/shadowfield/wavelets_gloss.h ==== */

/* ---- wavelets: BRDFs on texels ---- */

#ifndef SFIELD_WITHOUT_GLOSS
typedef struct sfield__lobe {       /* how a point looks to its eye */
    float n[3], v[3];               /* the normal, and to the eye */
    float mirror[3], exponent;      /* Phong: n, or 0 for the metal-rough BRDF */
    float a2, nv, go;               /* metal-rough: alpha^2, n . v and what Smith's shadowing has of both */
    float width;                    /* of the lobe's half vectors, or of the lobe: a tangent */
    int   narrow;                   /* not 0: the metal-rough lobe is not much wider than texels */
} sfield__lobe;

/* Returns a unit tangent of a surface that points to the eye, or anywhere if the eye is along the normal. */
static SFIELD__COLD sfield__v3 sfield__find_tangent(sfield__v3 n, sfield__v3 view)
{
    sfield__v3 t = sfield__v3_sub(view, sfield__v3_scale(n, sfield__v3_dot(n, view)));
    if (sfield__v3_dot(t, t) < 1e-12f)
        t = sfield__v3_cross(n, fabsf(n.x) < 0.6f ? sfield__v3_make(1, 0, 0) : sfield__v3_make(0, 1, 0));
    return sfield__v3_normalize(t);
}

/* Prepares a point's BRDF. set->exponents or set->materials are there. */
static SFIELD__COLD void sfield__read_lobe(const sfield_points *set, size_t index, const float *n,
                                           const float *view,
                              sfield__lobe *b)
{
    const sfield__v3 up = sfield__v3_load(n), v = sfield__v3_load(view);
    float alpha;
    b->exponent = 0;
    b->narrow = 0;
    b->nv = sfield__v3_dot(up, v);
    sfield__v3_store(b->n, up);
    sfield__v3_store(b->v, v);
    sfield__v3_store(b->mirror, sfield__v3_sub(sfield__v3_scale(up, 2 * b->nv), v));
    if (!set->materials) {
        b->exponent = sfield__exponent_of(set, index);
        b->width = sqrtf(2 / b->exponent);
        return;
    }
    alpha = sfield__alpha_of(sfield__value_of(set->materials, set->material_stride, index)[4]);
    if (b->nv < 1e-3f) {            /* below the horizon an eye looks along the surface, as in the table */
        b->nv = 1e-3f;
        sfield__v3_store(b->v, sfield__v3_madd(sfield__find_tangent(up, v), up, 1e-3f));
    }
    b->a2 = alpha * alpha;
    b->go = sqrtf(b->a2 + (1 - b->a2) * b->nv * b->nv);
    b->width = alpha;
    b->narrow = alpha < 0.08f;
}

/* Adds the kernels times cosine in a direction: of the lobe to out[1], of the metal-rough BRDF to all
   three. */
static void sfield__add_response(const sfield__lobe *b, const float *l, float *out)
{
    const float nl = b->n[0] * l[0] + b->n[1] * l[1] + b->n[2] * l[2];
    float h[3], hh = 0, along = 0, across = 0;
    float q, s, all;
    if (!(nl > 0)) return;
    if (b->exponent > 0) {
        along = b->mirror[0] * l[0] + b->mirror[1] * l[1] + b->mirror[2] * l[2];
        if (along > 0) out[1] += nl * (b->exponent + 2) * 0.159154943f * sfield__pow(along, b->exponent);
        return;
    }
    for (int k = 0; k < 3; k++) {
        h[k] = l[k] + b->v[k];
        hh += h[k] * h[k];
        along += h[k] * b->n[k];
    }
    /* 1 - (n . h)^2 by what of h lies across n: the difference would have few digits where a shallow light
       meets a shallow eye */
    for (int k = 0; k < 3; k++) {
        const float part = h[k] - along * b->n[k];
        across += part * part;
    }
    hh = hh > 4e-6f ? hh : 4e-6f;
    q = (across + along * along * b->a2) / hh;
    s = hh < 4 ? 0.25f * hh : 1;                /* (v . h)^2 */
    s = 1 - sqrtf(s);
    s = s * s * (s * s) * s;
    all = nl * 0.159154943f * b->a2 / (q * q);
    all /= nl * b->go + b->nv * sqrtf(b->a2 + (1 - b->a2) * nl * nl);
    out[0] += nl * 0.318309886f * (1 - s);
    out[1] += all * (1 - s);
    out[2] += all * s;
}

/* Returns into how many parts a side a texel is divided, so that one part is not wider than half of what the
   lobe changes over there. */
static uint32_t sfield__count_parts(const sfield__lobe *b, const float *l, float texel)
{
    float h[3], off = 0, hh = 0;
    float hv = 0, wide;
    uint32_t k;
    if (b->exponent > 0) {
        for (k = 0; k < 3; k++) off += l[k] * b->mirror[k];
        /* the lobe's tail has nothing fine */
        if (off < 1 - 8 * b->width * b->width - texel) return 1;
        return (uint32_t)(2 * texel / b->width) + 1;
    }
    for (k = 0; k < 3; k++) {
        h[k] = l[k] + b->v[k];
        hh += h[k] * h[k];
        off += h[k] * b->n[k];
        hv += h[k] * b->v[k];
    }
    if (!(off > 0)) return 1;
    /* h turns by 1 / (2 v . h) of what l turns, or half of it */
    texel *= 0.5f * sqrtf(hh) / (hv > 1e-3f ? hv : 1e-3f);
    off = hh / (off * off) - 1;
    wide = 0.5f * ((off > 0 ? sqrtf(off) : 0) - texel);
    wide = wide > b->width ? wide : b->width;
    k = (uint32_t)(2 * texel / wide) + 1;
    return k < 16 ? k : 16;
}

/* Fills planes of texels with the kernels times cosine times solid angle: a lobe's in the second of them, or
   those of the metal-rough BRDF in three. */
static void sfield__fill_texels(const sfield_scene *s, const sfield__lobe *b, float *planes)
{
    const uint32_t cells = s->cells, chains = b->exponent > 0 ? 2 : 3;
    const float texel = 1.57079633f / (float)s->side;
    uint32_t i, k, part, parts;
    uint32_t face, x, y;
    for (i = 0; i < cells; i++) {
        float l[3], out[3] = { 0, 0, 0 }, scale;
        for (k = 0; k < 3; k++) l[k] = s->texel[k * cells + i];
        parts = b->narrow ? 1 : sfield__count_parts(b, l, texel);
        if (parts == 1) sfield__add_response(b, l, out);
        else sfield__texel_place(s->side, i, &face, &x, &y);
        for (part = 0; parts > 1 && part < parts * parts; part++) {
            const double step = 2.0 / ((double)parts * s->side);
            double d[3], unit;
            sfield__from_face(face, (x * parts + part % parts + 0.5) * step - 1,
                              (y * parts + part / parts + 0.5) * step - 1, d);
            unit = 1 / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            for (k = 0; k < 3; k++) l[k] = (float)(d[k] * unit);
            sfield__add_response(b, l, out);
        }
        scale = s->texel[3 * cells + i] / (float)(parts * parts);
        for (k = 0; k < chains; k++) planes[k * cells + i] = out[k] * scale;
    }
}

/* Fills the planes of D V of a lobe that is not much wider than texels: directions are drawn on an even grid,
   and each adds to the texel that it falls into. */
static SFIELD__COLD void sfield__scatter_lobe(const sfield_scene *s, const sfield__lobe *b, float *planes)
{
    const float c = b->nv < 1 ? b->nv : 1.0f, view[3] = { sqrtf(1 - c * c), 0, c };
    const float share = 1.0f / (float)(4 * SFIELD__DRAWS * SFIELD__DRAWS);
    float *facing = planes + s->cells, *grazing = facing + s->cells;
    const sfield__v3 n = sfield__v3_load(b->n), t = sfield__find_tangent(n, sfield__v3_load(b->v));
    const sfield__v3 u = sfield__v3_cross(n, t);
    uint32_t at, side;
    memset(facing, 0, 2 * (size_t)s->cells * sizeof *facing);
    for (at = 0; at < 2 * SFIELD__DRAWS * SFIELD__DRAWS; at++) {
        double number, turn[2];
        float l[3], w, fifth;
        sfield__find_draw(at / 2, &number, turn);
        number += (at & 1 ? 0.25 : -0.25) / (double)SFIELD__DRAWS;
        w = sfield__draw_direction(view, b->width, b->go, number, turn, l, &fifth) * l[2] * share;
        for (side = 0; side < 2 && l[2] > 0; side++) {
            const float y = side ? -l[1] : l[1];
            float d[3];
            uint32_t texel;
            sfield__v3_store(d, sfield__v3_make(l[0] * t.x + y * u.x + l[2] * n.x,
                                                l[0] * t.y + y * u.y + l[2] * n.y,
                                                l[0] * t.z + y * u.z + l[2] * n.z));
            texel = sfield_cube_find(s->side, d);
            facing[texel] += w * (1 - fifth);
            grazing[texel] += w * fifth;
        }
    }
}

/* Shades a point with gloss: T begins with the BRDF, once for each kernel, and goes through the same
   entities as that of rgb. */
static SFIELD__COLD void sfield__light_gloss(sfield__point *p, const sfield__tile *one, uint64_t *hash,
                                             float *ambient)
{
    const sfield_scene *s = p->s;
    const sfield_points *set = p->set;
    const size_t index = one->first;
    const uint32_t chains = p->chains;
    float x[3], n[3], view[3], sum[3][3] = { { 0 } };
    float *rgb = p->rgb, *gloss = set->gloss + 3 * index;
    sfield_scene_stats stats;
    sfield__lobe b;
    uint32_t count, until;
    uint32_t c;
    for (c = 0; c < 3; c++) {
        x[c] = one->p[16 * c];
        n[c] = one->n[16 * c];
        view[c] = one->view[16 * c];
    }
    count = sfield__find_rays(p, x, n);
    until = sfield__find_stale(p, index, count, hash);
    if (until) {
        sfield__read_lobe(set, index, n, view, &b);
        sfield__fill_texels(s, &b, p->kernels);
        if (b.narrow) sfield__scatter_lobe(s, &b, p->kernels);
    }
    stats = p->stats;
    for (c = 0; c < chains; c++) {
        p->kernel = chains == 2 && c == 0 ? NULL : p->kernels + (size_t)c * s->cells;
        p->chain = c;
        p->rgb = sum[c];
        sfield__light_chain(p, index, x, n, count, until, hash, c == 0 ? ambient : NULL);
        if (c == 0) stats = p->stats;
    }
    p->stats = stats;                           /* entities count once */
    p->kernel = NULL;
    p->chain = 0;
    for (c = 0; c < 3; c++) {
        if (chains == 2) {
            rgb[c] = sum[0][c];
            gloss[c] = sum[1][c];
        } else {
            const float f0 =
                sfield__facing_of(sfield__value_of(set->materials, set->material_stride, index), c);
            rgb[c] = sum[0][c] * (1 - f0) * 3.14159265f;        /* the caller divides by pi */
            gloss[c] = f0 * sum[1][c] + sum[2][c];
            if (set->grazing) set->grazing[3 * index + c] = sum[2][c];
        }
    }
}
#endif

/* ==== src/shadowfield/wavelets_shade.h ==== */

/* ---- wavelets: shading a set of points ---- */

static void sfield__shade_set_haar(const sfield__job *job, const sfield_points *set, size_t piece,
                                   uint8_t *memory, sfield_scene_stats *stats)
{
    const sfield_scene *s = job->s;
    uint64_t *hash = (uint64_t *)(void *)memory;
    const uint32_t rays = s->occluder_count + s->light_count;
    int bundles = sfield__can_bundle(s, set);
    uint32_t kernels = 0;
    sfield__point p;
    sfield__bundle b;
    size_t i, k;
    memset(&p, 0, sizeof p);
    memset(&b, 0, sizeof b);
    p.chains = 1;
#ifndef SFIELD_WITHOUT_GLOSS
    p.chains = (uint32_t)sfield__count_chains(set);
    if (p.chains > 1) {                         /* each point by itself */
        bundles = 0;
        kernels = SFIELD__KERNELS;
    }
#endif
    p.s = b.s = s;
    p.set = set;
    p.all_hash = p.set_hash = sfield__hash_set(s, set);
    p.stats = *stats;
    memory += ((size_t)s->light_count + 8) / 8 * 64;
    memory += sfield__carve_point(&p, memory, rays, s->cells, kernels);
    (void)sfield__carve_bundle(&b, memory, rays, s->side);
    for (i = piece * SFIELD__LANES; i < set->count; i += job->pieces * SFIELD__LANES) {
        const size_t end = i + SFIELD__LANES < set->count ? i + SFIELD__LANES : set->count;
        if (set->gloss) memset(set->gloss + 3 * i, 0, 3 * (end - i) * sizeof *set->gloss);
        if (set->gloss && set->grazing) memset(set->grazing + 3 * i, 0, 3 * (end - i) * sizeof *set->gloss);
        if (bundles) sfield__shade_bundle(&p, &b, i, (uint32_t)(end - i), hash);
        for (k = i; k < end && !bundles; k++) sfield__shade_point(&p, k, hash);
    }
    *stats = p.stats;
}

/* Counts the bytes of memory that a task of sfield__shade_set_haar needs. */
static uint64_t sfield__scratch_haar(const sfield_scene *s, uint32_t kernels)
{
    const uint32_t rays = s->occluder_count + s->light_count;
    return sfield__carve_point(NULL, NULL, rays, s->cells, kernels) +
           (uint64_t)sfield__carve_bundle(NULL, NULL, rays, s->side) + ((size_t)s->light_count + 8) / 8 * 64;
}

/* Returns the entity of a set if it is rotated and only receives, so has no table for a resampling, and the
   set's self-visibility, in wavelets, needs one; else NULL. */
static sfield__item *sfield__find_unmapped(const sfield_scene *s, const sfield_points *p)
{
    sfield__item *it = !p->entity || !p->count || !p->self || s->algebra ? NULL : &s->item[p->entity - 1];
    return it && !it->identity && !it->map ? it : NULL;
}

/* Makes tables for the entities that sfield__find_unmapped finds, so that other receivers need none. */
static sfield_result sfield__map_receivers(sfield_scene *s, const sfield_points *sets, size_t count)
{
    const size_t cells = s->cells;
    sfield__taps *grown;
    uint32_t more = 0;
    size_t i;
    for (i = 0; i < count; i++) more += sfield__find_unmapped(s, &sets[i]) != NULL;
    if (!more) return SFIELD_OK;
    grown =
        (sfield__taps *)sfield__alloc_array(&s->allocator, ((size_t)s->maps + more) * cells, sizeof *grown);
    if (!grown) return SFIELD_ERR_ALLOC;
    if (s->maps) memcpy(grown, s->taps, s->maps * cells * sizeof *grown);
    sfield__free(&s->allocator, s->taps);
    s->taps = grown;
    for (i = 0; i < count; i++) {
        sfield__item *it = sfield__find_unmapped(s, &sets[i]);
        if (!it) continue;
        sfield__make_taps(s, it->turn, s->taps + s->maps * cells);
        it->map = ++s->maps;
    }
    return SFIELD_OK;
}

/* ==== src/shadowfield/shade.h ==== */

/* ---- shading: the public calls ---- */

static void sfield__shade_set_sh(const sfield__job *job, const sfield_points *set, size_t piece,
                                 uint8_t *memory, sfield_scene_stats *stats)
{
    const sfield_scene *s = job->s;
    const uint64_t hash = sfield__hash_set(s, set);
    sfield__tile t;
    size_t i;
    memset(&t, 0, sizeof t);
    t.s = s;
    t.set = set;
    t.lights = s->light_count;
    t.sky = s->has_sky || s->has_sun || set->ambient;
    t.chains = 1;
#ifndef SFIELD_WITHOUT_GLOSS
    t.chains = sfield__count_chains(set);
#endif
    t.all_round = job->incident != NULL;
    t.set_hash = hash;
    t.stats = *stats;
    (void)sfield__carve_tile(&t, memory, s->occluder_count, t.lights, s->coefs, (uint32_t)t.chains);
    for (i = piece * SFIELD__LANES; i < set->count; i += job->pieces * SFIELD__LANES) {
        t.first = i;
        t.lanes = set->count - i < SFIELD__LANES ? (uint32_t)(set->count - i) : (uint32_t)SFIELD__LANES;
#ifndef SFIELD_WITHOUT_GLOSS
        if (t.chains > 1 && set->cache) t.set_hash = sfield__hash_brdfs(hash, set, i, t.lanes);
#endif
        if (job->incident) sfield__shade_incident(&t, job->incident);
        else sfield__shade_tile(&t);
    }
    *stats = t.stats;
}

static void sfield__shade_task(void *context, size_t piece)
{
    sfield__job *job = (sfield__job *)context;
    uint8_t *memory = job->s->scratch + piece * job->scratch;
    size_t i;
    memory += (64 - ((uintptr_t)memory & 63)) & 63;
    for (i = 0; i < job->set_count; i++)
#ifndef SFIELD_WITHOUT_WAVELETS
        if (!job->s->algebra) sfield__shade_set_haar(job, &job->sets[i], piece, memory, &job->stats[piece]);
        else
#endif
            sfield__shade_set_sh(job, &job->sets[i], piece, memory, &job->stats[piece]);
}

/* Checks pointers, strides and the entity of a set. */
static sfield_result sfield__check_arrays(const sfield__logger *log, const sfield_scene *s,
                                          const sfield_points *p)
{
    if (!sfield__check_value(log, p->count <= 0x7fffffffu, "points->count", (double)p->count, "below 2^31"))
        return SFIELD_ERR_LIMIT;
    if (!sfield__points_good(log, p) ||
        !sfield__check_value(
            log, p->to_eye_stride % 4 == 0 && (!p->to_eye || sfield__stride_valid(p->to_eye_stride, 12)),
            "points->to_eye_stride", (double)p->to_eye_stride, "0, or a multiple of 4 of at least 12") ||
        !sfield__check_value(log, p->exponent_stride % 4 == 0, "points->exponent_stride",
                             (double)p->exponent_stride, "a multiple of 4"))
        return SFIELD_ERR_ARGUMENT;
    if (!sfield__check_value(log, p->entity <= s->item_count, "points->entity", p->entity,
                             "0, or 1 for the first entity, ..."))
        return SFIELD_ERR_INPUT;
    return SFIELD_OK;
}

static sfield_result sfield__check_set(const sfield__logger *log, const sfield_scene *s,
                                       const sfield_points *p)
{
    sfield_result result;
    if (p->count == 0) return SFIELD_OK;
    result = sfield__check_arrays(log, s, p);
    if (result != SFIELD_OK) return result;
#ifdef SFIELD_WITHOUT_GLOSS
    if (p->gloss)
        return sfield__fail(log, SFIELD_ERR_MISMATCH, "points->gloss",
                            "is not in this header, joined without gloss");
#else
    result = sfield__count_chains(p) > 1 ? sfield__check_gloss(log, p) : SFIELD_OK;
    if (result != SFIELD_OK) return result;
#endif
    if (p->self && !sfield__field_fits(s, p->self, SFIELD__KIND_SELF))
        return sfield__fail(log, SFIELD_ERR_MISMATCH, "points->self",
                            "is not a self-visibility of the scene's basis and bands");
    if (p->self && !sfield__check_value(log, p->self->h.samples == p->count, "points->self's count",
                                        p->self->h.samples, "points->count"))
        return SFIELD_ERR_MISMATCH;
#ifndef SFIELD_WITHOUT_WAVELETS
    if (s->desc.product == SFIELD_PRODUCT_SPARSE && sfield__find_unmapped(s, p))
        return sfield__fail(log, SFIELD_ERR_MISMATCH, "points->self",
                            "is on a rotated entity, which SFIELD_PRODUCT_SPARSE does not do");
#endif
    if (p->cache && (p->cache->coefs != s->coefs || !p->cache->cells != !!s->algebra))
        return sfield__fail(log, SFIELD_ERR_MISMATCH, "points->cache",
                            "is not of the scene's basis and bands");
    if (p->cache && !sfield__check_value(log, p->cache->points == p->count, "points->cache's count",
                                         (double)p->cache->points, "points->count"))
        return SFIELD_ERR_MISMATCH;
    result = sfield__check_units(log, "points->normals", p->normals, p->normal_stride, p->count);
#ifndef SFIELD_WITHOUT_GLOSS
    if (result == SFIELD_OK && sfield__count_chains(p) > 1)
        result = sfield__check_units(log, "points->to_eye", p->to_eye, p->to_eye_stride, p->count);
#endif
    return result;
}

static sfield_result sfield__shade_all(sfield__job *job, sfield_scene_stats *stats)
{
    sfield_scene *s = job->s;
    const uint64_t *from;
    uint64_t *to;
    uint64_t bytes = 64;
    uint32_t chains = 1;
    size_t i, k;
#ifndef SFIELD_WITHOUT_GLOSS
    for (i = 0; i < job->set_count; i++) {
        const uint32_t own = (uint32_t)sfield__count_chains(&job->sets[i]);
        chains = own > chains ? own : chains;
#ifndef SFIELD_WITHOUT_CACHE
        if (job->sets[i].count && job->sets[i].cache && job->sets[i].cache->chains < own &&
            sfield__lay_cache(job->sets[i].cache, own) != SFIELD_OK)
            return SFIELD_ERR_ALLOC;
#endif
    }
    if (chains == 3 && s->algebra && !s->brdf && sfield__make_brdf(s) != SFIELD_OK) return SFIELD_ERR_ALLOC;
#endif
#ifndef SFIELD_WITHOUT_WAVELETS
    if (!s->algebra) bytes += sfield__scratch_haar(s, chains > 1 ? 3 : 0);
    else
#endif
        bytes += sfield__carve_tile(NULL, NULL, s->occluder_count, s->light_count, s->coefs, chains);
    job->pieces = s->desc.system.parallel_for ? (uint32_t)SFIELD__PIECES : 1u;
    if (bytes > SIZE_MAX / job->pieces) return SFIELD_ERR_ALLOC;
    job->scratch = (size_t)bytes;
    if (job->scratch * job->pieces > s->scratch_bytes) {
        uint8_t *grown = (uint8_t *)sfield__alloc(&s->allocator, job->scratch * job->pieces);
        if (!grown) return SFIELD_ERR_ALLOC;
        sfield__free(&s->allocator, s->scratch);
        s->scratch = grown;
        s->scratch_bytes = job->scratch * job->pieces;
    }
    memset(job->stats, 0, sizeof job->stats);
    if (s->desc.system.parallel_for)
        s->desc.system.parallel_for(s->desc.system.user, job->pieces, sfield__shade_task, job);
    else sfield__shade_task(job, 0);
    if (!stats) return SFIELD_OK;
    memset(stats, 0, sizeof *stats);
    to = &stats->points;
    for (i = 0; i < job->pieces; i++)           /* eight counters of 64 bits, then the overlaps */
        for (k = 0, from = &job->stats[i].points; k < 8; k++) to[k] += from[k];
    stats->overlaps = s->overlaps;
#ifndef SFIELD_WITHOUT_ROOMS
    stats->rooms = s->held_count;
#endif
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_shade(sfield_scene *scene, const sfield_points *sets, size_t set_count,
                                      sfield_scene_stats *stats)
{
    sfield__job job;
    size_t i;
    sfield__logger log;
    if (!scene) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&scene->desc.system, "sfield_shade");
    if (!sets && set_count) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "sets", "is NULL");
    for (i = 0; i < set_count; i++) {
        sfield_result result = sfield__check_set(&log, scene, &sets[i]);
        if (result != SFIELD_OK) return result;
    }
#ifndef SFIELD_WITHOUT_WAVELETS
    if (sfield__map_receivers(scene, sets, set_count) != SFIELD_OK) return SFIELD_ERR_ALLOC;
#endif
    job.s = scene;
    job.sets = sets;
    job.set_count = set_count;
    job.incident = NULL;
    return sfield__shade_all(&job, stats);
}

SFIELD_DEF sfield_result sfield_incident(sfield_scene *scene, const sfield_points *set, float *coefs)
{
    sfield__job job;
    sfield_result result;
    sfield__logger log;
    if (!scene) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&scene->desc.system, "sfield_incident");
    if (!set || !coefs) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, set ? "coefs" : "set", "is NULL");
    result = sfield__check_set(&log, scene, set);
    if (result != SFIELD_OK) return result;
    if (!scene->algebra || scene->desc.product == SFIELD_PRODUCT_EXP)
        return sfield__fail(&log, SFIELD_ERR_MISMATCH, "scene", "has no products of harmonics");
    job.s = scene;
    job.sets = set;
    job.set_count = 1;
    job.incident = coefs;
    return sfield__shade_all(&job, NULL);
}

/* ==== src/shadowfield/sparse.h ==== */

/* ---- sparse vertices: shade few, interpolate the rest ---- */

typedef struct sfield__cell { int32_t x, y, z, side; uint32_t point; } sfield__cell;

static int sfield__compare_cells(const void *a, const void *b)
{
    const sfield__cell *p = (const sfield__cell *)a, *q = (const sfield__cell *)b;
    if (p->x != q->x) return p->x < q->x ? -1 : 1;
    if (p->y != q->y) return p->y < q->y ? -1 : 1;
    if (p->z != q->z) return p->z < q->z ? -1 : 1;
    if (p->side != q->side) return p->side < q->side ? -1 : 1;
    return p->point < q->point ? -1 : p->point > q->point;
}

/* Finds a cell by its place and side among sorted cells. Returns NULL if no point lies there. */
static const sfield__cell *sfield__find_cell(const sfield__cell *cells, size_t count,
                                             const sfield__cell *key)
{
    size_t low = 0, high = count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (sfield__compare_cells(&cells[middle], key) < 0) low = middle + 1;
        else high = middle;
    }
    if (low == count || cells[low].x != key->x || cells[low].y != key->y || cells[low].z != key->z ||
        cells[low].side != key->side)
        return NULL;
    return &cells[low];
}

/* Finds the three representatives nearest to a point among the 27 cells around it whose surface faces the
   same way. */
static void sfield__find_sources(const sfield__cell *cells, size_t count, const sfield__cell *own,
                            const sfield_points *points, float spacing, const uint32_t *chosen,
                            uint32_t *sources, float *weights)
{
    float best[3] = { 3e38f, 3e38f, 3e38f }, sum = 0;
    const float *p = sfield__row(points->positions, points->position_stride, own->point),
                unit = sfield__unit(spacing);
    int32_t i;
    uint32_t k, j;
    sources[0] = sources[1] = sources[2] = 0;
    for (i = 0; i < 27; i++) {
        sfield__cell key = *own;
        const sfield__cell *c;
        const float *there;
        float d2 = 0, to;
        key.x += i % 3 - 1;
        key.y += i / 3 % 3 - 1;
        key.z += i / 9 - 1;
        key.point = 0;
        c = sfield__find_cell(cells, count, &key);
        if (!c) continue;
        there = sfield__row(points->positions, points->position_stride, chosen[c->point]);
        for (k = 0; k < 3; k++) {
            to = there[k] * unit - p[k] * unit;
            d2 += to * to;
        }
        for (k = 0; k < 3 && d2 >= best[k]; k++) { }
        for (j = 2; k < 3 && j > k; j--) {
            best[j] = best[j - 1];
            sources[j] = sources[j - 1];
        }
        if (k < 3) {
            best[k] = d2;
            sources[k] = c->point;
        }
    }
    /* inverse distances; the own representative alone where it is hit */
    for (k = 0; k < 3; k++) {
        weights[k] = best[k] < 3e38f ? 1 / (best[k] + 1e-30f) : 0;
        sum += weights[k];
    }
    for (k = 0; k < 3; k++) {
        weights[k] /= sum;
        if (best[k] >= 3e38f) sources[k] = sources[0];
    }
}

/* Checks that all points can be put into cells. */
static sfield_result sfield__check_sparse(const sfield__logger *log, const sfield_points *points,
                                          float spacing)
{
    size_t i, k;
    if (!sfield__points_good(log, points) ||
        !sfield__check_value(log, points->count > 0, "points->count", 0, "> 0") ||
        !sfield__check_value(log, spacing > 0 && sfield__finite(spacing), "spacing", (double)spacing, "> 0"))
        return SFIELD_ERR_ARGUMENT;
    if (!sfield__check_value(log, points->count <= 0x7fffffffu, "points->count", (double)points->count,
                             "below 2^31"))
        return SFIELD_ERR_LIMIT;
    for (i = 0; i < points->count; i++) {
        const float *p = sfield__row(points->positions, points->position_stride, i);
        const float *n = sfield__row(points->normals, points->normal_stride, i);
        for (k = 0; k < 3; k++)
            if (!sfield__in(p[k] / spacing, -1e9f, 1e9f) || !sfield__finite(n[k]))
                return sfield__fail_at(log, SFIELD_ERR_INPUT, "points", i,
                                       "is not finite, or more than 1e9 times the spacing away");
    }
    return SFIELD_OK;
}

/* Finds the cell of each point, a cube and a side, and sorts the points by their cells. */
static void sfield__sort_into_cells(const sfield_points *points, float spacing, sfield__cell *cells)
{
    size_t i, count = points->count;
    uint32_t k;
    for (i = 0; i < count; i++) {
        const float *p = sfield__row(points->positions, points->position_stride, i);
        int32_t at[3];
        for (k = 0; k < 3; k++) at[k] = (int32_t)(p[k] / spacing) - (p[k] < 0);
        cells[i].x = at[0];
        cells[i].y = at[1];
        cells[i].z = at[2];
        cells[i].side = (int32_t)sfield__face_of(sfield__row(points->normals, points->normal_stride, i));
        cells[i].point = (uint32_t)i;
    }
    qsort(cells, count, sizeof *cells, sfield__compare_cells);
}

SFIELD_DEF sfield_result sfield_sparse(const sfield_points *points, float spacing,
                                       const sfield_system *system, uint32_t *chosen, size_t *chosen_count,
                                       uint32_t *sources, float *weights)
{
    const sfield__logger log = sfield__logger_of(system, "sfield_sparse");
    sfield__allocator a = sfield__allocator_of(system);
    sfield_result result;
    sfield__cell *cells, *first;
    float best = 3e38f;
    size_t i, n = 0, count;
    uint32_t k;
    if (!points || !chosen || !chosen_count || !sources || !weights)
        return sfield__fail(&log, SFIELD_ERR_ARGUMENT,
                            !points         ? "points"
                            : !chosen       ? "chosen"
                            : !chosen_count ? "chosen_count"
                            : !sources      ? "sources"
                                            : "weights",
                            "is NULL");
    if (!sfield__system_good(system)) return sfield__fail_allocator(&log);
    result = sfield__check_sparse(&log, points, spacing);
    if (result != SFIELD_OK) return result;
    count = points->count;
    cells = (sfield__cell *)sfield__alloc_array(&a, 2 * count, sizeof *cells);
    if (!cells) return SFIELD_ERR_ALLOC;
    first = cells + count;
    sfield__sort_into_cells(points, spacing, cells);
    for (i = 0; i < count; i++) {               /* the point nearest to a cell's middle stands for it */
        const float *p = sfield__row(points->positions, points->position_stride, cells[i].point);
        float middle[3], d2 = 0;
        middle[0] = (float)cells[i].x;
        middle[1] = (float)cells[i].y;
        middle[2] = (float)cells[i].z;
        for (k = 0; k < 3; k++)
            d2 += (p[k] / spacing - middle[k] - 0.5f) * (p[k] / spacing - middle[k] - 0.5f);
        if (!i || cells[i].x != cells[i - 1].x || cells[i].y != cells[i - 1].y ||
            cells[i].z != cells[i - 1].z || cells[i].side != cells[i - 1].side) {
            first[n] = cells[i];
            first[n].point = (uint32_t)n;
            n++;
            best = 3e38f;
        }
        if (d2 < best) {
            chosen[n - 1] = cells[i].point;
            best = d2;
        }
    }
    for (i = 0; i < count; i++)
        sfield__find_sources(first, n, &cells[i], points, spacing, chosen,
                             sources + 3 * (size_t)cells[i].point, weights + 3 * (size_t)cells[i].point);
    *chosen_count = n;
    sfield__free(&a, cells);
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_spread(size_t count, const uint32_t *sources, const float *weights,
                                       size_t chosen_count, const float *rgb, float *out)
{
    size_t i, k, c;
    if (!sources || !weights || !rgb || !out) return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < 3 * count; i++)
        if (sources[i] >= chosen_count) return SFIELD_ERR_INPUT;
    for (i = 0; i < count; i++)
        for (c = 0; c < 3; c++) {
            float sum = 0;
            for (k = 0; k < 3; k++) sum += weights[3 * i + k] * rgb[3 * (size_t)sources[3 * i + k] + c];
            out[3 * i + c] = sum;
        }
    return SFIELD_OK;
}

/* ==== src/shared/fp_end.h ==== */

/* unit fp_end: the user's options again. clang and MSVC keep contraction off to the end of the file. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__)
#pragma GCC pop_options
#endif

/* ==== src/shadowfield/end.h ==== */

#endif /* SHADOWFIELD_IMPLEMENTATION */

/*
Dapple is available under either of the two licences below, at your choice:
MIT-0 OR Unlicense.

------------------------------------------------------------------------------
MIT No Attribution

Copyright 2026 The Dapple authors

Permission is hereby granted, free of charge, to any person obtaining a copy
of this software and associated documentation files (the "Software"), to deal
in the Software without restriction, including without limitation the rights
to use, copy, modify, merge, publish, distribute, sublicense, and/or sell
copies of the Software, and to permit persons to whom the Software is
furnished to do so.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR
IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY,
FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER
LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM,
OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE
SOFTWARE.

------------------------------------------------------------------------------
The Unlicense

This is free and unencumbered software released into the public domain.

Anyone is free to copy, modify, publish, use, compile, sell, or distribute
this software, either in source code form or as a compiled binary, for any
purpose, commercial or non-commercial, and by any means.

In jurisdictions that recognize copyright laws, the author or authors of this
software dedicate any and all copyright interest in the software to the public
domain. We make this dedication for the benefit of the public at large and to
the detriment of our heirs and successors. We intend this dedication to be an
overt act of relinquishment in perpetuity of all present and future rights to
this software under copyright law.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR
IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY,
FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
AUTHORS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN
ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION
WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.

For more information, please refer to <https://unlicense.org/>
*/
