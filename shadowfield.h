/* shadowfield.h - v1.0.0 - shadow fields: soft shadows of many moving objects under moving lights - MIT-0 OR Unlicense

   What it does

   Records once, at sample points on spheres round an object, which part of the sky it hides (an occlusion field), and
   round a light, what it radiates there (a source field). At run time any number of instances move, turn and scale
   evenly; the light that reaches a point is a product of a few field samples, with soft shadows from local lights,
   video lights and environment together. After Zhou, Hu, Lin, Guo and Shum, "Precomputed Shadow Fields for Dynamic
   Scenes", SIGGRAPH 2005. Two bases: real spherical harmonics (fast, soft) and Haar wavelets (all frequencies, slow).

   What it does not do

   - Objects are rigid. Light does not bounce. Shading is per point: yours are vertices, probes or pixels.
   - Four bands of harmonics blur everything below about 45 degrees; hard shadows of small lights need wavelets.
   - No rendering, no file access, no threads of its own.

   Quick start

   In exactly one source file write the define; everywhere else include the header alone.

       #define SHADOWFIELD_IMPLEMENTATION
       #include "shadowfield.h"
       #include <stdio.h>

       int main(void)
       {
           static const float corners[] = { -1, 0, -1,  1, 0, -1,  1, 0, 1,  -1, 0, 1 };    // a square
           static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2 };
           const float place[6] = { 0, -0.5f, 0,  6, -0.5f, 0 }, up[6] = { 0, 1, 0,  0, 1, 0 };
           sfield_mesh mesh = { corners, 4, 0, triangles, 6 };
           sfield_entity square = sfield_entity_default();
           sfield_points points = { 0 };
           const float sky[3] = { 1, 1, 1 };
           float rgb[6];
           sfield_field *field;
           sfield_scene *scene;

           if (sfield_build(NULL, &mesh, &field, NULL) != SFIELD_OK) return 1;     // 384 KB, within a second
           if (sfield_scene_create(NULL, &scene) != SFIELD_OK) return 1;
           square.occlusion = field;                                               // square.transform: where it is now
           sfield_scene_entities(scene, &square, 1);
           sfield_scene_environment(scene, sky, 1, 1, NULL);                       // radiance 1 from everywhere
           points.count = 2;
           points.positions = place;
           points.normals = up;
           points.entity = SFIELD_NONE;                                            // the points are in world space
           points.rgb = rgb;
           sfield_shade(scene, &points, 1, NULL);
           printf("irradiance / pi: %g below the square, %g beside it\n", (double)rgb[0], (double)rgb[3]);
           sfield_scene_free(scene);
           sfield_free(field);
           return !(rgb[0] < 0.7f && rgb[3] > 0.9f);
       }

   Conventions

   Right-handed; matrices are column-major float[16]; directions have unit length and point from the surface to the
   light; distances in your units, angles in radians; radiance in W/(sr m^2), irradiance in W/m^2.

     r          radius of the bounding sphere of an entity; o, its centre, is the centre of the field
     entity     an instance of an occlusion field, of a source field or of both, with its own transform
     shell      one of the concentric spheres; its sample points lie on the grid of a cube, 6 x side x side
     cube       what is seen from a sample point: 6 x N x N texels, faces +X -X +Y -Y +Z -Z as OpenGL orders them
     texel      number face N^2 + morton(x, y): sfield_cube_texel gives its direction and solid angle
     occlusion  alpha: 1 hidden, 0 free. Queries return visibility, 1 - alpha
     bands      of spherical harmonics: n bands are n^2 coefficients, number l^2 + l + m; Y1 = 0.4886 (y, z, x)
     vectors    of coefficients come in planes: coefficient k of vector i is v[k * stride + i], so that 16 vectors are
                treated at a time; stride 1 is a plain single vector

   How it works

   A query finds the shells around the distance d and interpolates eight samples. Shells are geometric by default and
   weights linear in the solid angle of the bounding sphere (occlusion) or in (r/d)^2 (sources); beyond the last shell
   both fall as (r/d)^2, which is how small things look from afar. For a point the product T = BRDF x cosine x own
   visibility is multiplied by the visibility of each entity from near to far; a light adds its dot product with the T
   that stands when it is reached; the environment is the farthest light.

     harmonics  coefficients of 8 bits, scaled for shell, band and order: shells x 6 side^2 x n^2 bytes (x 3 lights)
     wavelets   orthonormal on the planar face of a cube; the largest are kept, 4 bytes each (8 for lights). With
                all defaults a box takes 15 s and 33 MB, a lamp 50 s and 62 MB (harmonics 0.6 s and 0.4, 3 s and 1.2)

     bands            fewer: faster, softer; light leaks round objects. More: n^4 growth of products
     position_side    fewer: shadows wobble as things move past sample points
     keep             fewer wavelets: noise of 2 x 2 texels in shadows
     cube_side        fewer texels: penumbrae in steps
     keep_inside      0: positions inside a closed mesh (counter-clockwise from outside) take the view from its surface;
                      else they see nothing, and darken receivers near it

   Configuration

     SHADOWFIELD_IMPLEMENTATION   in one source file: compiles the code
     SHADOWFIELD_STATIC           everywhere it is included: a private copy, all functions static
     SFIELD_DEF                   everywhere: your own linkage instead
     SFIELD_NO_SIMD               with the implementation: no intrinsics (results equal but for rounding)
     SFIELD_ASSERT(x)             with the implementation: in place of assert

   Memory, errors, threads, determinism

   All memory comes from the allocator in the desc, called from the thread that called us. Every function that can fail
   returns a sfield_result; where it is not SFIELD_OK, outputs are untouched and nothing leaks. There are no globals:
   fields and algebras are read by any number of threads; a scene belongs to one call at a time, which spreads its work
   by your parallel-for. Built fields have the same bytes on every compiler, processor, byte order and thread count (not
   with x87 arithmetic, nor with clang's -ffast-math). Shading does not depend on the number of threads.

   Cost: docs/shadowfield.md and build/bench sfield_algebra, sfield_chess, sfield_wavelet.   History: CHANGELOG.md.
   Licence: end of this file. */
#ifndef SHADOWFIELD_H
#define SHADOWFIELD_H

#define SFIELD_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#include <stddef.h>
#include <stdint.h>

#ifndef SFIELD_DEF
#ifdef SHADOWFIELD_STATIC
#define SFIELD_DEF static inline
#else
#define SFIELD_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- results ---- */

#define SFIELD_RESULTS(X)                                                                                    \
    X(SFIELD_OK, "ok")                                                                                       \
    X(SFIELD_ERR_ARGUMENT, "an argument is NULL, zero, not finite or out of range")                          \
    X(SFIELD_ERR_DESC, "a desc field is out of range")                                                       \
    X(SFIELD_ERR_INPUT, "the mesh cannot be used")                                                           \
    X(SFIELD_ERR_ALLOC, "the allocator returned no memory")                                                  \
    X(SFIELD_ERR_MEMORY, "the caller's buffer is too small")                                                 \
    X(SFIELD_ERR_LIMIT, "a size overflows or passes a limit of the format")                                  \
    X(SFIELD_ERR_CANCELLED, "cancelled by the progress callback")                                            \
    X(SFIELD_ERR_FORMAT, "not a shadowfield file, or a damaged one")                                         \
    X(SFIELD_ERR_VERSION, "a shadowfield file of an unknown version")                                        \
    X(SFIELD_ERR_BASIS, "basis, bands, cube or content of the fields do not fit this call")                  \
    X(SFIELD_ERR_OVERLAP, "bounding spheres of a light and an object overlap (strict)")                      \
    X(SFIELD_ERR_ROTATION, "a rotated entity needs the product on texels")                                   \
    X(SFIELD_ERR_SHARD, "not the shards of one field, or a shard where the whole is needed")

typedef enum sfield_result {
#define SFIELD__ENUM(name, text) name,
    SFIELD_RESULTS(SFIELD__ENUM)
#undef SFIELD__ENUM
    SFIELD_RESULT_COUNT
} sfield_result;

SFIELD_DEF const char *sfield_result_text(sfield_result result);
/* A constant string for any value, "unknown result" beyond the list. */

/* ---- memory, threads, progress: the caller's ---- */

typedef struct sfield_allocator {   /* all zero = malloc and free; else both functions */
    void *(*alloc_fn)(size_t size, void *user);   /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} sfield_allocator;

typedef void (*sfield_task)(void *context, size_t index);
typedef void (*sfield_parallel_for)(void *user, size_t count, sfield_task task, void *context);
/* Must call task(context, i) once for each i < count, in any order and on any threads, and return when all are done. */

typedef int (*sfield_progress)(void *user, float fraction);
/* Called between shells, or parts of a file, from the thread that called us, fraction 0..1 never falling; not 0
   cancels. */

/* ---- spherical harmonics ---- */

#define SFIELD_MAX_BANDS 8u
#define SFIELD_MAX_COEFS 64u

typedef struct sfield_algebra sfield_algebra;      /* tables of one number of bands; read-only once made */

SFIELD_DEF sfield_result sfield_algebra_create(uint32_t bands, const sfield_allocator *allocator, sfield_algebra **out);
/* bands 1..8, allocator may be NULL. Errors SFIELD_ERR_ARGUMENT, SFIELD_ERR_ALLOC. Cost 1 to 100 ms, 0.1 to 1 MB. */
SFIELD_DEF void sfield_algebra_free(sfield_algebra *algebra);      /* accepts NULL */

SFIELD_DEF void sfield_sh_basis(uint32_t bands, const double direction[3], double *y);
/* Writes bands^2 (bands 1..8) values of the real basis at a unit direction. */

SFIELD_DEF sfield_result sfield_sh_product(const sfield_algebra *algebra, size_t count, const float *a, const float *b,
                                           float *out, size_t stride);
/* out = a b, projected on the same bands (the tripling coefficients, all of them): exact up to that truncation.
   a, b, out  planes of count vectors, stride >= count floats from coefficient to coefficient; out may be a or b
   Errors     SFIELD_ERR_ARGUMENT. Cost: about 30 ns (4 bands, AVX2) over 3, see docs */

SFIELD_DEF size_t sfield_sh_terms(const sfield_algebra *algebra, uint32_t *terms, float *factors);
/* What the product is made of, for shaders: out_k += factor (a_i b_j + a_j b_i), once where i = j, for i >= j >= 1 and
   k >= 1; what has an index 0 is 0.2821 (a_0 b_k + a_k b_0), and 0.2821 a.b for k = 0.
   terms    i | j << 8 | k << 16, rising in k; NULL, like factors, to be told only how many. Returns their number */

SFIELD_DEF sfield_result sfield_sh_dot(uint32_t bands, size_t count, const float *a, const float *b, float *out,
                                       size_t stride);
/* out[i] = integral of a_i b_i over the sphere. Arguments as above; out holds count floats. */

typedef struct sfield_rotation {
    uint32_t bands;
    int      identity;
    float    block[680];        /* (2l+1) x (2l+1) for each band, by rows */
} sfield_rotation;

SFIELD_DEF sfield_result sfield_sh_rotation(const sfield_algebra *algebra, const float matrix[16],
                                            sfield_rotation *out);
/* matrix  rotation (times one scale > 0; translation is ignored). A function f turns into f(R^-1 w).
   Errors  SFIELD_ERR_ARGUMENT. Cost 2 us (4 bands) to 50 us (8): once for each entity and frame, not for each vector */

SFIELD_DEF sfield_result sfield_sh_rotate(const sfield_rotation *rotation, size_t count, const float *in, float *out,
                                          size_t stride);
/* in and out as planes; out may be in. */

SFIELD_DEF sfield_result sfield_sh_product_n(uint32_t bands, uint32_t functions, const float *coefs,
                                             const sfield_allocator *allocator, double *out);
/* Exact product of several functions without truncation between them, on a grid of full order.
   functions  1..32; coefs holds bands^2 floats of each, one after the other
   out        bands^2 coefficients of the product; its integral is sqrt(4 pi) out[0]
   Errors     SFIELD_ERR_ARGUMENT, SFIELD_ERR_ALLOC */

SFIELD_DEF sfield_result sfield_sh_log(const sfield_algebra *algebra, const float *visibility, float *out);
SFIELD_DEF sfield_result sfield_sh_exp(const sfield_algebra *algebra, size_t count, const float *in, float *out,
                                       size_t stride);
/* Ren et al. 2006: a product of visibilities is the exp of the sum of their logs, whatever their order. log works on
   one vector by the eigenvalues of its product matrix, clipped below at 0.02; exp on planes, by scaling and
   squaring. */

SFIELD_DEF void sfield_sh_window(uint32_t bands, float strength, float factors[SFIELD_MAX_BANDS]);
/* Against ringing: factor 1 / (1 + strength l^2 (l+1)^2) for band l. */
SFIELD_DEF float sfield_sh_window_fit(uint32_t bands, const float *coefs, float lowest);
/* The least strength (0..1) with which the function stays >= lowest everywhere (checked at 2,592 directions); 1 also
   where none does, as with a mean below lowest. */

SFIELD_DEF void sfield_sh_cosine(uint32_t bands, float factors[SFIELD_MAX_BANDS]);
/* A_l of max(0, cos): convolving radiance coefficients with them gives irradiance. */

/* ---- cubes and Haar wavelets ---- */

SFIELD_DEF float sfield_cube_texel(uint32_t side, uint32_t texel, float direction[3]);
/* Unit direction of a texel's centre and, returned, its solid angle. side: a power of two, 2..64. */
SFIELD_DEF uint32_t sfield_cube_find(uint32_t side, const float direction[3]);
/* The texel that a direction falls into. */
SFIELD_DEF sfield_result sfield_cube_basis(uint32_t bands, uint32_t side, uint32_t texel, float *out);
/* Exact integrals of the bands^2 basis functions over a texel: sums of texels times these are a function's
   coefficients. For projection elsewhere (gl_backend.h). Errors SFIELD_ERR_ARGUMENT. */

SFIELD_DEF sfield_result sfield_sh_project(uint32_t bands, uint32_t side, const float *texels, uint32_t channels,
                                           float *coefs);
/* Integrates a cube of texels (channels values each, 1..3) against the basis, exactly over each texel; coefs: bands^2
   for each channel, one channel after the other. Errors SFIELD_ERR_ARGUMENT. */

SFIELD_DEF sfield_result sfield_haar_forward(uint32_t side, const float *texels, float *coefs);
SFIELD_DEF sfield_result sfield_haar_inverse(uint32_t side, const float *coefs, float *texels);
/* 2D Haar of all six faces, orthonormal over the texels of the planar face; 6 side^2 floats each, not the same array.
   On a face, [0] is the scaling coefficient, and [4^j + 3 node + t] wavelet t (x, y, both) of level j. */
SFIELD_DEF sfield_result sfield_haar_product(uint32_t side, const float *a, const float *b, float *out);
/* Coefficients of the product of two functions given by coefficients, walking only where both have any below a square
   (Ng, Ramamoorthi and Hanrahan 2004): time by non-zero coefficients, not texels. out: another array */

/* ---- fields ---- */

typedef struct sfield_mesh {
    const float    *positions;      /* x, y, z of each vertex */
    size_t          vertex_count;
    size_t          vertex_stride;  /* bytes from one vertex to the next, a multiple of 4, >= 12; 0 = 12 */
    const uint32_t *indices;        /* three to a triangle; NULL = 0, 1, 2, ... */
    size_t          index_count;    /* a multiple of 3 (ignored without indices: vertex_count is used) */
} sfield_mesh;

typedef enum sfield_basis {
    SFIELD_BASIS_DEFAULT,           /* = SFIELD_BASIS_SH */
    SFIELD_BASIS_SH,
    SFIELD_BASIS_HAAR,
    SFIELD_BASIS_COUNT
} sfield_basis;

typedef enum sfield_spacing {       /* of the shells */
    SFIELD_SPACING_DEFAULT,         /* = SFIELD_SPACING_GEOMETRIC */
    SFIELD_SPACING_GEOMETRIC,       /* interpolated in solid angle: within 2 % of a sphere between shells */
    SFIELD_SPACING_UNIFORM,         /* as in the paper, interpolated in d: 15 % wrong at 1.5 r */
    SFIELD_SPACING_COUNT
} sfield_spacing;

typedef struct sfield_desc {
    sfield_basis   basis;
    uint32_t       bands;           /* harmonics: 1..8; 0 = 4 */
    uint32_t       cube_side;       /* N, a power of two, 4..64; 0 = 16 (harmonics), 32 (wavelets) */
    uint32_t       shells;          /* 2..64; 0 = 16, 32 */
    uint32_t       position_side;   /* 2..64; 0 = 16, 32 */
    sfield_spacing spacing;
    float          inner, outer;    /* first and last shell, in r, 0.001 <= inner, 1.1 inner <= outer <= 1000, no two
                                       shells within 0.02 %; 0 = 0.2 and 8 (20) */
    float          keep;            /* wavelets: at most this share of a cube's 6 N^2 coefficients, 0..1; 0 = 0.01 */
    float          window;          /* harmonics: sfield_sh_window of every cube, >= 0; 0 = none */
    int            logarithm;       /* harmonics: not 0 stores log visibility, for SFIELD_PRODUCT_EXP */
    uint32_t       frames;          /* sources: 1..256 steps of time; 0 = 1 */
    float          frames_per_second; /* > 0; 0 = 30 */
    int            loop;            /* not 0: after the last frame the first; 0: the last stays; so before time 0 */
    float          center[3], radius; /* bounding sphere, which must hold the mesh or emitter; radius 0 = fitted
                                         (callbacks: required) */
    uint32_t       shard_begin, shard_end; /* only these shells, counted through all frames; 0, 0 = all. Not SELF */
    sfield_allocator    allocator;
    sfield_parallel_for parallel_for; /* NULL = this thread alone; the bytes built are the same */
    void               *parallel_user;
    sfield_progress     progress;   /* NULL = none */
    void               *progress_user;
    int            keep_inside;     /* meshes: not 0: positions inside closed ones see nothing (the paper); 0: they take
                                       the view from just outside the surface */
} sfield_desc;                      /* zero it, then set what you care about */

typedef struct sfield_stats {       /* of a build */
    uint32_t triangles;             /* used */
    uint32_t skipped_triangles;     /* a vertex not finite, or two corners equal */
    uint64_t coefficients;          /* wavelets kept */
    double   lost;                  /* wavelets: relative L2 error of what was not kept, over all samples */
    size_t   peak_bytes;            /* asked of the allocator at once */
    uint64_t moved;                 /* positions inside the mesh whose view was taken outside */
} sfield_stats;

typedef struct sfield_field sfield_field;

SFIELD_DEF sfield_result sfield_build(const sfield_desc *desc, const sfield_mesh *mesh, sfield_field **out,
                                      sfield_stats *stats);
/* Occlusion field of a mesh. desc may be NULL (all defaults), stats may be NULL.
   Errors   SFIELD_ERR_DESC, SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_INPUT (stride, index count, an index beyond
            vertex_count, no triangle left), SFIELD_ERR_ALLOC, SFIELD_ERR_LIMIT, SFIELD_ERR_CANCELLED
   Memory   the field + 16 tasks of about 26 bytes a vertex and 0.2 MB + samples of one shell
   Cost     shells x 6 side^2 views of all triangles, and as much again for positions inside: of 10,000 triangles
            seconds (harmonics) to minutes (wavelets), of a box 0.6 and 15 s */

SFIELD_DEF sfield_result sfield_build_emissive(const sfield_desc *desc, const sfield_mesh *mesh, const float *radiance,
                                               sfield_field **out, sfield_stats *stats);
/* Source field of an emissive mesh. radiance: r, g, b of each triangle, >= 0, for each frame one array after the other;
   emitted on the side that is counter-clockwise; both sides: the triangle once more, turned over. Triangles of radiance
   0 hide those behind. Errors as above. */

typedef void (*sfield_view_fn)(void *user, float time, const float position[3], const float direction[3], float rgb[3]);
/* What arrives at position, in the field's space, from the unit direction (pointing away from position): radiance, or
   alpha in rgb[0]. Called from your threads. Values that are not finite count as 0, negative ones as well. */

typedef enum sfield_emitter_kind {
    SFIELD_EMITTER_DEFAULT,         /* = SFIELD_EMITTER_SPHERE */
    SFIELD_EMITTER_SPHERE,          /* radius about the centre */
    SFIELD_EMITTER_DISC,            /* radius about the centre, emits along normal */
    SFIELD_EMITTER_RECTANGLE,       /* centre, half axes u and v; emits along u x v */
    SFIELD_EMITTER_CALLBACK,        /* view, nothing from outside the bounding sphere */
    SFIELD_EMITTER_KIND_COUNT
} sfield_emitter_kind;

typedef struct sfield_emitter {     /* all in the field's space, about desc.center */
    sfield_emitter_kind kind;
    float radius;                   /* > 0 */
    float normal[3];                /* unit */
    float u[3], v[3];
    float radiance[3];              /* >= 0 */
    float cosine;                   /* cone: half apex angle's cosine about normal; 0 with no normal set: everywhere */
    sfield_view_fn view;
    void *user;
} sfield_emitter;

SFIELD_DEF sfield_result sfield_build_emitter(const sfield_desc *desc, const sfield_emitter *emitter,
                                              sfield_field **out, sfield_stats *stats);
/* Source field of an analytic light or of a callback. desc.radius 0 = fitted (callback: required).
   Errors  SFIELD_ERR_DESC (desc or emitter), SFIELD_ERR_ARGUMENT, SFIELD_ERR_ALLOC, _LIMIT, _CANCELLED */

SFIELD_DEF sfield_result sfield_build_callback(const sfield_desc *desc, sfield_view_fn alpha, void *user,
                                               sfield_field **out, sfield_stats *stats);
/* Occlusion field by your own renderer: alpha 0..1. desc.radius is required. Errors as above. */

typedef struct sfield_views {       /* sample points of a shell, 1..256 at a time, to be seen from */
    float        center[3], radius; /* bounding sphere of the field */
    float        time;              /* seconds, of a source's frame */
    size_t       count;
    const float *eyes;              /* (position - center) / radius, three floats each */
    float       *values;            /* for you to write, for each eye. Harmonics: bands^2 coefficients; wavelets: 6 N^2
                                       texels. Of alpha, 1 hidden; of sources: of r, then g, then b */
} sfield_views;

typedef int (*sfield_views_fn)(void *user, const sfield_views *views);
/* Not 0 ends the build. From the thread that called us, shell after shell. Coefficients: as by sfield_cube_basis. Eyes
   lie on the shell, or just outside the mesh. */

SFIELD_DEF sfield_result sfield_build_views(const sfield_desc *desc, int source, const sfield_mesh *mesh,
                                            sfield_views_fn see, void *user, sfield_field **out, sfield_stats *stats);
/* A field whose cubes another renderer draws and projects, such as glbk_sfield_builder of gl_backend.h; windows,
   logarithms, the choice of wavelets and the block are made here.
   source   not 0: of radiance, else of occlusion
   mesh     what you draw, for the bounding sphere, the inscribed one and positions inside, which are asked again from
            outside (keep_inside); NULL = desc.radius is required, none inscribed, none moved
   Values that are not finite or beyond 1e18 count as 0.
   Errors   as sfield_build; SFIELD_ERR_CANCELLED where `see` returned not 0 */

SFIELD_DEF sfield_result sfield_build_self(const sfield_desc *desc, const sfield_mesh *mesh, const float *points,
                                           const float *normals, size_t count, float offset, sfield_field **out,
                                           sfield_stats *stats);
/* Self-visibility of count points on the mesh, the O_p of the paper: the view from points[i] + offset normals[i] (three
   floats each). Harmonics store visibility x max(0, cosine), wavelets the occlusion. For sfield_points.self. Points in
   parts that run into each other are taken outside too (keep_inside). */

SFIELD_DEF sfield_result sfield_merge(const sfield_field *const *shards, size_t count, const sfield_desc *desc,
                                      sfield_field **out);
/* Joins shards of one desc whose shells follow each other from the first to the last; the bytes are those of the whole
   build.
   desc     for its allocator and progress only; may be NULL
   Errors   SFIELD_ERR_ARGUMENT, SFIELD_ERR_DESC (allocator), SFIELD_ERR_SHARD, SFIELD_ERR_LIMIT, SFIELD_ERR_ALLOC,
            SFIELD_ERR_CANCELLED */

SFIELD_DEF void sfield_free(sfield_field *field);      /* accepts NULL */

typedef enum sfield_kind { SFIELD_KIND_OCCLUSION, SFIELD_KIND_SOURCE, SFIELD_KIND_SELF } sfield_kind;

typedef struct sfield_info {
    sfield_kind    kind;
    sfield_basis   basis;
    uint32_t       bands, cube_side, shells, position_side, frames;
    sfield_spacing spacing;
    int            logarithm;
    size_t         samples;         /* cubes recorded; SELF: points */
    uint64_t       coefficients;    /* wavelets in all of them */
    size_t         bytes;           /* of the block, which is the file too */
    float          center[3], radius;
    float          inscribed;       /* radius of a sphere about center inside the closed mesh; 0 = none known */
    float          inner, outer;    /* in r */
    uint32_t       shard_begin, shard_end; /* 0, 0: whole */
} sfield_info;

SFIELD_DEF void sfield_get_info(const sfield_field *field, sfield_info *out);

SFIELD_DEF sfield_result sfield_query(const sfield_field *field, size_t count, const float *positions, float time,
                                      float *out);
/* The field at positions (three floats each, in its own space), eight samples interpolated.
   out      harmonics: bands^2 coefficients for each position (sources: r, then g, then b); wavelets: 6 N^2 texels
            likewise. Visibility (or its log, as stored), or radiance
   Errors   SFIELD_ERR_ARGUMENT; SFIELD_ERR_BASIS for SELF fields; SFIELD_ERR_SHARD. Positions that are not finite see
            nothing: visibility 1, radiance 0 */

SFIELD_DEF sfield_result sfield_self(const sfield_field *field, size_t first, size_t count, float *out);
/* Coefficients or texels of a SELF field as stored, from point first on. Errors SFIELD_ERR_ARGUMENT, _BASIS. */

SFIELD_DEF sfield_result sfield_ambient(const sfield_field *field, size_t count, const float *positions, float *out);
/* Free by-product: share of all directions that stays open at each position, 0..1; of harmonics from the first
   coefficient alone.
   Errors  SFIELD_ERR_ARGUMENT, SFIELD_ERR_BASIS (not an occlusion field, or its log), SFIELD_ERR_SHARD */

SFIELD_DEF size_t sfield_size(const sfield_field *field);
SFIELD_DEF sfield_result sfield_write(const sfield_field *field, void *memory, size_t memory_size);
/* The file, sfield_size() bytes, little-endian. Errors SFIELD_ERR_ARGUMENT, SFIELD_ERR_MEMORY. */
SFIELD_DEF sfield_result sfield_open(const void *data, size_t size, const sfield_desc *desc, sfield_field **out);
/* Copies and checks a file: every size, offset, index and number in it.
   desc    for its allocator and progress only; may be NULL
   Errors  SFIELD_ERR_ARGUMENT, SFIELD_ERR_DESC (allocator), SFIELD_ERR_FORMAT, SFIELD_ERR_VERSION, SFIELD_ERR_ALLOC,
           SFIELD_ERR_CANCELLED */

/* ---- scenes ---- */

typedef struct sfield_scene sfield_scene;

#define SFIELD_NONE 0xffffffffu

typedef enum sfield_product_mode {
    SFIELD_PRODUCT_DEFAULT,         /* harmonics: TRIPLE; wavelets: TEXELS */
    SFIELD_PRODUCT_TRIPLE,          /* harmonics: projected after every product */
    SFIELD_PRODUCT_EXP,             /* harmonics: one exp of the sum of logs for each light; needs fields of logs */
    SFIELD_PRODUCT_TEXELS,          /* wavelets: expanded where they have detail, multiplied on texels */
    SFIELD_PRODUCT_SPARSE,          /* wavelets: sublinear product of coefficients (the paper); no rotated entities but
                                       those that only receive, without a self-visibility */
    SFIELD_PRODUCT_COUNT
} sfield_product_mode;

typedef struct sfield_scene_desc {
    sfield_basis        basis;
    uint32_t            bands;          /* harmonics: 1..8; 0 = 4. Fields must have the same */
    uint32_t            cube_side;      /* wavelets: as the fields; 0 = 32. Harmonics: of the environment; 0 = 16 */
    sfield_product_mode product;
    float               reach;          /* occluders count up to this many r, fading over the last quarter (third
                                           culling rule); > 0; 0 = the outermost shell of the field */
    int                 strict;         /* not 0: overlapping light and object are SFIELD_ERR_OVERLAP */
    sfield_allocator    allocator;
    sfield_parallel_for parallel_for;   /* NULL = this thread alone */
    void               *parallel_user;
} sfield_scene_desc;

typedef struct sfield_entity {
    const sfield_field *occlusion;      /* NULL = hides nothing; must outlive its use by the scene */
    const sfield_field *source;         /* NULL = does not shine */
    float transform[16];                /* field space to world: rotation, one scale > 0, translation */
    float tint[3];                      /* factor of the source's radiance */
    float time;                         /* seconds, of a source with frames */
} sfield_entity;

SFIELD_DEF sfield_entity sfield_entity_default(void);
/* No fields, identity, tint 1: a transform of zeros and a tint of 0 mean what they say. */

typedef struct sfield_scene_stats {
    uint64_t points;                /* shaded (not masked) */
    uint64_t pairs;                 /* of a point and an occluder that is not its own */
    uint64_t culled_far, culled_horizon, culled_hidden;   /* pairs left out by each of the three rules */
    uint64_t products;              /* of a point's T with an occluder */
    uint64_t lights;                /* dot products of a point with a light */
    uint64_t reused;                /* of them, with a T from the cache */
    uint32_t overlaps;              /* pairs of a light and an object whose bounding spheres overlap */
} sfield_scene_stats;

SFIELD_DEF sfield_result sfield_scene_create(const sfield_scene_desc *desc, sfield_scene **out);
/* desc may be NULL. Errors SFIELD_ERR_DESC, SFIELD_ERR_ARGUMENT, SFIELD_ERR_ALLOC. */
SFIELD_DEF void sfield_scene_free(sfield_scene *scene);      /* accepts NULL */

SFIELD_DEF sfield_result sfield_scene_entities(sfield_scene *scene, const sfield_entity *entities, size_t count);
/* Where everything is now; copied. At most 65535. Call it for each frame in which something moved.
   Errors  SFIELD_ERR_ARGUMENT (transform), SFIELD_ERR_BASIS, _SHARD, _OVERLAP (strict), _ROTATION,
           SFIELD_ERR_LIMIT, SFIELD_ERR_ALLOC; the scene then keeps what it had */

SFIELD_DEF sfield_result sfield_scene_environment(sfield_scene *scene, const float *rgb, uint32_t width,
                                                  uint32_t height, const float rotation[16]);
/* Distant light as a latitude-longitude map of radiance: row 0 is +Y, the centre is +X, +Z right of it. Copied.
   rgb       width x height x 3, from +Y down; NULL = no environment. Texels not finite or negative count as 0; each
             has one radiance, and its exact solid angle
   rotation  map to world, or NULL. Errors SFIELD_ERR_ARGUMENT, SFIELD_ERR_ALLOC */
SFIELD_DEF sfield_result sfield_scene_turn(sfield_scene *scene, const float rotation[16]);
/* Another rotation of the same environment: one rotation of coefficients, or of one cube map. */
SFIELD_DEF sfield_result sfield_scene_sun(sfield_scene *scene, const float direction[3], const float irradiance[3]);
/* Adds a direction of light to the environment until it is set again (not turned by sfield_scene_turn). direction NULL
   takes all of them away: set what moved anew, and the map stays. Errors SFIELD_ERR_ARGUMENT */

SFIELD_DEF sfield_result sfield_scene_sky(const sfield_scene *scene, float *coefs);
/* Environment and suns as they are now, for shaders: bands^2 coefficients of r, then g, then b. Harmonics only: else
   SFIELD_ERR_BASIS. SFIELD_ERR_ARGUMENT: NULL */

typedef struct sfield_cache sfield_cache;       /* T of a set of points for each light: lazy occlusion updating */

SFIELD_DEF sfield_result sfield_cache_create(const sfield_scene *scene, size_t point_count, uint32_t light_count,
                                             sfield_cache **out);
/* For light_count lights (the environment is one) of a scene of this basis. 4 n^2 bytes a point and light with
   harmonics, filled with the first frame; 4 bytes a wavelet kept. From the scene's allocator. Entities that move or
   change, another scene, `entity` or `self` are noticed; positions and normals that you rewrite (a mesh that deforms,
   another level of detail) are not: free it and create another. Errors SFIELD_ERR_ARGUMENT, _ALLOC */
SFIELD_DEF void sfield_cache_free(sfield_cache *cache);      /* accepts NULL */
SFIELD_DEF size_t sfield_cache_bytes(const sfield_cache *cache);

typedef struct sfield_points {      /* receivers that belong together, neighbours side by side. Strides in bytes,
                                       multiples of 4; of three floats 12 or more */
    size_t              count;
    const float        *positions;  size_t position_stride;   /* 3 floats; 0 = 12. In entity's space, or world space */
    const float        *normals;    size_t normal_stride;     /* 3 floats, unit: with a length that is off by more than
                                                                 5 % all results of the point are 0, without an error */
    uint32_t            entity;     /* the entity that they lie on: moves them, and neither hides nor lights them; or
                                       SFIELD_NONE: 0 is the first entity */
    const sfield_field *self;       /* SELF field of the same count, or NULL = convex and flat: nothing of its own
                                       hides */
    const uint8_t      *visible;    /* 0: leave this point out (its outputs become 0); NULL = all */
    const float        *views;      size_t view_stride;       /* 3 floats, unit, world, to the eye; Phong only */
    const float        *exponents;  size_t exponent_stride;   /* Phong: n of each point, 1..1000; NULL = no lobe. Stride
                                                                 0: one for all */
    sfield_cache       *cache;      /* NULL = nothing is kept. Of this set alone. Not used with gloss and exponents */
    float              *rgb;        /* 3 floats a point: integral of L V cos / pi; times albedo: radiance. NULL = no */
    float              *gloss;      /* 3 floats: integral of L V cos (n+2)/(2 pi) cos^n(angle to the mirrored view).
                                       Harmonics only; 0 without exponents, which want views */
    float              *ambient;    /* 1 float: integral of V cos / pi */
} sfield_points;

SFIELD_DEF sfield_result sfield_shade(sfield_scene *scene, const sfield_points *sets, size_t set_count,
                                      sfield_scene_stats *stats);
/* Direct light at all points of all sets, near to far (paper, figure 5). Not clamped: ringing may go below 0, and
   surfaces that face a sun are 25 % too dark with 2 bands, 6 % too bright with 3 or 4.
   Errors  SFIELD_ERR_ARGUMENT (NULL, stride, an entity beyond the list, a lobe without views), SFIELD_ERR_BASIS (self
           or cache of another basis or count, gloss in wavelets), SFIELD_ERR_ROTATION (self on a rotated entity,
           SPARSE), SFIELD_ERR_ALLOC. Points that are not finite get 0
   Cost    harmonics: about 0.1 us for a point and an occluder in reach */

SFIELD_DEF sfield_result sfield_incident(sfield_scene *scene, const sfield_points *set, float *coefs);
/* Incident radiance instead, far to near, occluders common to several lights applied once (paper 3.2). Harmonics only.
   coefs   3 n^2 floats a point, world space, without self-visibility and BRDF: of all directions, whatever the normal,
           which must be there all the same. Errors as above */

/* ---- sparse vertices: shade few, interpolate the rest ---- */

SFIELD_DEF sfield_result sfield_sparse(const float *positions, const float *normals, size_t count, float spacing,
                                       const sfield_allocator *allocator, uint32_t *chosen, size_t *chosen_count,
                                       uint32_t *sources, float *weights);
/* For objects far from the eye: chooses about one point for each cube of edge `spacing` and side of the surface.
   chosen   room for count; the *chosen_count points to shade, in order
   sources  3 numbers into chosen for each point, weights: 3 floats, sum 1
   Errors   SFIELD_ERR_ARGUMENT, SFIELD_ERR_ALLOC. Cost O(count log count) */
SFIELD_DEF sfield_result sfield_spread(size_t count, const uint32_t *sources, const float *weights,
                                       size_t chosen_count, const float *rgb, float *out);
/* out[i] = sum of weights x rgb of its sources. Errors SFIELD_ERR_ARGUMENT (also a source out of range). */

#ifdef __cplusplus
}
#endif

#endif /* SHADOWFIELD_H */

/* ==== implementation ============================================================================================== */

#if defined(SHADOWFIELD_IMPLEMENTATION) && !defined(SHADOWFIELD_IMPLEMENTED)
#define SHADOWFIELD_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifndef SFIELD_ASSERT
#include <assert.h>
#define SFIELD_ASSERT(condition) assert(condition)
#endif

#ifdef SFIELD_NO_SIMD
#define SFIELD__NO_SIMD
#endif

/* >>> shared fp_begin mem v3 m4 bytes crc trig cpu bits part: written by tools/stamp from src/shared, edit there */

/* unit fp_begin: the arithmetic that the bytes depend on, from here to unit fp_end */

/* No fused multiply-add that the source does not ask for: gcc fuses across statements in its gnu modes and on s390x,
   clang within expressions. A user's -ffast-math is taken back in gcc; in clang it, or -ffp-contract=fast, wins over
   the pragma: results then stay within tolerance but not equal to the bit. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && !defined(__TINYC__)
#pragma GCC push_options
#pragma GCC optimize("-ffp-contract=off", "-fno-fast-math", "-fno-trapping-math")
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif

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

/* *out = a * b and 1, or 0 and *out untouched where the product does not fit. */
static inline int sfield__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

/* Bytes between elements of floats that are `standard` large: 0 stands for that; else they do not overlap. */
static inline int sfield__stride_valid(size_t stride, size_t standard)
{
    return stride == 0 || (stride >= standard && stride % 4 == 0);
}

/* Takes the members of a public desc. Both functions or none: valid() is what the desc check asks. */
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

/* NULL where the size is 0 or overflows, so that a caller has one thing to test. */
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

/* a + b s */
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

/* Scaled by the largest component first, so that neither tiny nor huge vectors leave the float range.
   The zero vector stays zero. */
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

/* By the exponent bits, because compilers may take isfinite() for always true under -ffast-math. */
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

/* unit m4, needs v3: column-major 4 x 4 matrices, float[16], affine */

static inline sfield__v3 sfield__m4_point(const float *m, sfield__v3 p)
{
    return sfield__v3_make(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12], m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                     m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]);
}

/* Finite, with 0 0 0 1 as its last row. */
static inline int sfield__m4_is_affine(const float *m)
{
    int i;
    for (i = 0; i < 16; i++)
        if (!sfield__finite(m[i])) return 0;
    return m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f && m[15] == 1.0f;
}

/* 1 and *scale where m is a rotation times one scale > 0 (no mirroring) plus a translation: columns of equal length
   and at right angles within 1e-4, which is what products of float rotations reach. */
static inline int sfield__m4_is_rigid_uniform(const float *m, float *scale)
{
    sfield__v3 x = sfield__v3_load(m), y = sfield__v3_load(m + 4), z = sfield__v3_load(m + 8);
    float s, lx, ly, lz, tolerance;

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
    if (fabsf(sfield__v3_dot(y, z)) > 1e-4f || sfield__v3_dot(sfield__v3_cross(x, y), z) < 0.0f) return 0;
    *scale = s;
    return 1;
}

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

/* unit crc: CRC-32 as in zip and PNG (reflected 0xEDB88320) */

/* Begin with crc = 0 and go on with the last result. A table of 16: a nibble a step is fast enough for files and small
   enough to read. */
static inline uint32_t sfield__crc32(uint32_t crc, const void *data, size_t size)
{
    static const uint32_t table[16] = {
        0x00000000u, 0x1db71064u, 0x3b6e20c8u, 0x26d930acu, 0x76dc4190u, 0x6b6b51f4u, 0x4db26158u, 0x5005713cu,
        0xedb88320u, 0xf00f9344u, 0xd6d6a3e8u, 0xcb61b38cu, 0x9b64c2b0u, 0x86d3d2d4u, 0xa00ae278u, 0xbdbdf21cu
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

/* unit trig: elementary functions with the same bits on every machine */

/* Only + - * / and sqrt, which IEEE 754 rounds the same everywhere as long as nothing is contracted (unit fp_begin).
   Coefficients are minimax fits of our own. The float functions are free of branches and calls, so that loops over
   them vectorise at SSE2 level. Errors named below are the largest against the double functions, all float arguments or
   a dense set tried (tests/unit/shared_test.c). Out of range or NaN is clamped into the range, so that nothing here is
   undefined or returns NaN. */

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

/* Cody and Waite: pi/2 in three parts, of which the first two times k are exact for |k| < 2^13. |x| <= 8192: error 1e-7
   absolute. */
static inline void sfield__sincos(float x, float *sine, float *cosine)
{
    float t, r, z, s, c, a, b;
    int32_t k;

    t = x > -8192.0f ? x : -8192.0f;
    t = t < 8192.0f ? t : 8192.0f;
    k = (int32_t)(t * 0.636619772f + (t < 0.0f ? -0.5f : 0.5f));
    r = ((t - (float)k * 1.5703125f) - (float)k * 4.837512969970703125e-4f) - (float)k * 7.5497899548918822e-8f;
    z = r * r;
    s = r + r * z * (-0.1666665494f + z * (0.008332178146f + z * -0.0001951729898f));
    c = (1.0f - 0.5f * z) + z * z * (0.04166664687f + z * (-0.001388736752f + z * 2.443845159e-5f));
    a = k & 1 ? c : s;
    b = k & 1 ? s : c;
    *sine = k & 2 ? -a : a;
    *cosine = (k + 1) & 2 ? -b : b;
}

/* 2^k (1 + r + r^2 p(r)), |r| <= ln 2 / 2, in double: exp, log and pow err by 1 ulp. */
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
    p = 0.500000007785776445 + r * (0.166666668605852527 + r * (0.0416662700968242239 + r * (0.00833326438132814496 +
        r * p)));
    bits = (uint64_t)(k + 1023) << 52;
    memcpy(&power, &bits, sizeof power);
    return power * (1.0 + (r + r * r * p));
}

/* x > 0: x = 2^e m with m in [sqrt(1/2), sqrt(2)), log m = 2 artanh((m - 1) / (m + 1)). */
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
    z *= 0.333333328227282264 + z * (0.200001675954362054 + z * (0.142686542711926518 + z * 0.117910756496012977));
    return (double)e * 0.69314718055994531 + 2.0 * (s + s * z);
}

/* Infinity from 88.7228394 on. */
static inline float sfield__exp(float x)
{
    return x > 88.7228394f ? sfield__from_bits(0x7f800000u) : (float)sfield__exp_core((double)x);
}

/* -infinity where x is not above 0. */
static inline float sfield__log(float x)
{
    return x > 0.0f ? (float)sfield__log_core(x) : sfield__from_bits(0xff800000u);
}

/* x below 0 counts as 0; pow(0, y) is 0, 1 or infinity for y above, equal to or below 0. */
static inline float sfield__pow(float x, float y)
{
    double t;
    if (y == 0.0f) return 1.0f;
    if (!(x > 0.0f)) return y > 0.0f ? 0.0f : sfield__from_bits(0x7f800000u);
    t = (double)y * sfield__log_core(x);
    return t > 88.722839111 ? sfield__from_bits(0x7f800000u) : (float)sfield__exp_core(t);
}

/* unit cpu: run-time detection of x86 vector units */

/* SFIELD__X86 is 1 where functions with target attributes can be compiled and chosen at run time.
   SFIELD__NO_SIMD, defined by the header from its public switch, leaves all of it out. tcc has no attributes; MSVC
   needs none. clang in MSVC's place (clang-cl) hides the vector types unless all is built for them. */
#if !defined(SFIELD__NO_SIMD) && (defined(__x86_64__) || defined(__i386__)) && defined(__GNUC__) && !defined(__TINYC__)
#define SFIELD__X86 1
#define SFIELD__TARGET_AVX2 __attribute__((target("avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#define SFIELD__TARGET_AVX512 \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#elif !defined(SFIELD__NO_SIMD) && defined(_MSC_VER) && defined(_M_X64) && !defined(__clang__)
#define SFIELD__X86 1
#define SFIELD__TARGET_AVX2
#define SFIELD__TARGET_AVX512
#else
#define SFIELD__X86 0
#endif

#if SFIELD__X86 && defined(_MSC_VER)
#include <intrin.h>
/* Bit of leaf 7's ebx, after FMA and what the operating system saves were checked. */
static inline int sfield__cpu_leaf7(unsigned xcr0, unsigned ebx)
{
    int r[4];
    __cpuid(r, 0);
    if (r[0] < 7) return 0;
    __cpuid(r, 1);
    if (!(r[2] & 1 << 12) || !(r[2] & 1 << 27) || !(r[2] & 1 << 23)) return 0;   /* FMA, OSXSAVE, POPCNT */
    if (((unsigned)_xgetbv(0) & xcr0) != xcr0) return 0;
    __cpuidex(r, 7, 0);
    return ((unsigned)r[1] & ebx) == ebx;
}
static inline int sfield__cpu_has_avx2(void) { return sfield__cpu_leaf7(0x06u, 0x00000128u); }
static inline int sfield__cpu_has_avx512(void) { return sfield__cpu_leaf7(0xe6u, 0xc0030128u); }
#elif SFIELD__X86
/* The compiler's run time asks the operating system too. Every processor with BMI2 has LZCNT. */
static inline int sfield__cpu_has_avx2(void)
{
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
           __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
}
static inline int sfield__cpu_has_avx512(void)
{
    return sfield__cpu_has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}
#else
static inline int sfield__cpu_has_avx2(void) { return 0; }
static inline int sfield__cpu_has_avx512(void) { return 0; }
#endif

/* unit bits: counting bits */

static inline uint32_t sfield__popcount(uint64_t x)
{
    x -= x >> 1 & 0x5555555555555555u;
    x = (x & 0x3333333333333333u) + (x >> 2 & 0x3333333333333333u);
    x = (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    return (uint32_t)(x * 0x0101010101010101u >> 56);
}

/* unit part: the caller's progress within parts of a call, and whether it cancels */

/* progress may be NULL; from..to of 0..1. */
typedef struct sfield__part {
    int (*progress)(void *user, float fraction);
    void *user;
    float from, to;
} sfield__part;

/* Where progress is not NULL; fraction: of the part. */
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

/* Before step i of count, asked every so many steps. 1: the caller cancels. */
static inline int sfield__cancelled(const sfield__part *p, size_t i, size_t count, size_t every)
{
    return p->progress && i % every == 0 && sfield__part_tell(p, (float)((double)i / (double)count)) != 0;
}

/* <<< shared */

/* ---- >>kernels: sixteen lanes at a time ---- */

#if SFIELD__X86 && (defined(__x86_64__) || defined(_M_X64))
#define SFIELD__SIMD 1
#include <immintrin.h>
#else
#define SFIELD__SIMD 0
#endif

#if defined(__GNUC__) || defined(__clang__)
#define SFIELD__INLINE static inline __attribute__((always_inline))
#else
#define SFIELD__INLINE static inline
#endif

enum { SFIELD__LANES = 16, SFIELD__STAGED = 300, SFIELD__STAGED_COEFS = 25, SFIELD__PIECES = 16,    /* of 5 bands */
       SFIELD__SHARED = 3 };        /* lanes that the same eight samples must serve, on average */

typedef struct sfield__entry { uint32_t pair; float c; } sfield__entry;

struct sfield_algebra {
    sfield__allocator allocator;
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

/* Three or four versions of one text: V is a type of 16 floats. Pairs a_i b_j + a_j b_i are made once and serve one
   to three outputs; those with index 0 need no table, since C_0jj = Y_00. From 6 bands on the pairs would pass what a
   stack should hold, so that they are made again for every use. */
#define SFIELD__KERNELS(V, TARGET)                                                                                     \
    TARGET static void sfield__product_##V(const sfield_algebra *t, const float *a, const float *b, float *out,        \
                                           size_t stride, int occlude)                                                 \
    {                                                                                                                  \
        sfield__##V p[SFIELD__STAGED + SFIELD__STAGED_COEFS], *r, a0, b0, acc;                                         \
        uint32_t i, k, q, staged = t->pair_count <= SFIELD__STAGED;                                                    \
        r = p + (staged ? SFIELD__STAGED : 0);                                                                         \
        for (i = 1; i < t->coefs && staged; i++) {                                                                     \
            a0 = sfield__##V##_load(a + i * stride);                                                                   \
            b0 = sfield__##V##_load(b + i * stride);                                                                   \
            for (q = t->row[i]; q < t->row[i + 1]; q++) {                                                              \
                uint32_t j = t->pair[q];                                                                               \
                acc = sfield__##V##_mul(a0, sfield__##V##_load(b + j * stride));                                       \
                if (i != j) acc = sfield__##V##_fma(b0, sfield__##V##_load(a + j * stride), acc);                      \
                p[q] = acc;                                                                                            \
            }                                                                                                          \
        }                                                                                                              \
        acc = sfield__##V##_mul(sfield__##V##_load(a), sfield__##V##_load(b));                                         \
        for (k = 1; k < t->coefs; k++)                                                                                 \
            acc = sfield__##V##_fma(sfield__##V##_load(a + k * stride), sfield__##V##_load(b + k * stride), acc);      \
        r[0] = sfield__##V##_mul(acc, sfield__##V##_set1(sfield__y00));                                                \
        a0 = sfield__##V##_mul(sfield__##V##_load(a), sfield__##V##_set1(sfield__y00));                                \
        b0 = sfield__##V##_mul(sfield__##V##_load(b), sfield__##V##_set1(sfield__y00));                                \
        for (k = 1; k < t->coefs; k++) {                                                                               \
            acc = sfield__##V##_mul(a0, sfield__##V##_load(b + k * stride));                                           \
            acc = sfield__##V##_fma(b0, sfield__##V##_load(a + k * stride), acc);                                      \
            for (q = t->first[k]; q < t->first[k + 1]; q++) {                                                          \
                const sfield__entry *e = &t->entry[q];                                                                 \
                sfield__##V pair;                                                                                      \
                if (staged) pair = p[e->pair];                                                                         \
                else {                                                                                                 \
                    uint32_t u = t->pair_i[e->pair], v = t->pair[e->pair];                                             \
                    pair = sfield__##V##_mul(sfield__##V##_load(a + u * stride), sfield__##V##_load(b + v * stride));  \
                    if (u != v)                                                                                        \
                        pair = sfield__##V##_fma(sfield__##V##_load(a + v * stride),                                   \
                                                 sfield__##V##_load(b + u * stride), pair);                            \
                }                                                                                                      \
                acc = sfield__##V##_fma(sfield__##V##_set1(e->c), pair, acc);                                          \
            }                                                                                                          \
            r[k] = acc;                                                                                                \
        }                                                                                                              \
        for (k = 0; k < t->coefs; k++) {                                                                               \
            acc = occlude ? sfield__##V##_sub(sfield__##V##_load(a + k * stride), r[k]) : r[k];                        \
            sfield__##V##_store(out + k * stride, acc);                                                                \
        }                                                                                                              \
    }                                                                                                                  \
    TARGET static void sfield__rotate_##V(const sfield_rotation *rotation, const float *in, float *out, size_t stride, \
                                          int inverse)                                                                 \
    {                                                                                                                  \
        const float *block = rotation->block;                                                                          \
        sfield__##V r[2 * SFIELD_MAX_BANDS];                                                                           \
        uint32_t l, x, y, n, across, down;                                                                             \
        for (l = 0; l < rotation->bands; l++) {                                                                        \
            n = 2 * l + 1;                                                                                             \
            across = inverse ? n : 1;                                                                                  \
            down = inverse ? 1 : n;                                                                                    \
            for (y = 0; y < n; y++) {                                                                                  \
                const float *from = in + (size_t)l * l * stride, *m = block + y * down;                                \
                sfield__##V acc = sfield__##V##_mul(sfield__##V##_set1(m[0]), sfield__##V##_load(from));               \
                for (x = 1; x < n; x++)                                                                                \
                    acc = sfield__##V##_fma(sfield__##V##_set1(m[x * across]), sfield__##V##_load(from + x * stride),  \
                                            acc);                                                                      \
                r[y] = acc;                                                                                            \
            }                                                                                                          \
            for (y = 0; y < n; y++) sfield__##V##_store(out + ((size_t)l * l + y) * stride, r[y]);                     \
            block += n * n;                                                                                            \
        }                                                                                                              \
    }

/* Products of 4 bands, which most fields have, without loops: the branches of short loops cost more than the
   arithmetic. The pairs (number, i, j) and terms (entry, k, pair) are those of sfield_algebra's tables, in their order,
   so that the sums have the same bits. A change of the tables' order shows in four_bands_have_the_bits_of_the_loops of
   the tests; the lists are then printed from pair_i, pair, first and entry of an algebra of 4 bands. */
#define SFIELD__PAIRS4(X, V)                                                                                          \
    X(V, 0, 1, 1) X(V, 1, 2, 1) X(V, 2, 2, 2) X(V, 3, 3, 1) X(V, 4, 3, 2) X(V, 5, 3, 3) X(V, 6, 4, 1)                 \
    X(V, 7, 4, 2) X(V, 8, 4, 3) X(V, 9, 4, 4) X(V, 10, 5, 1) X(V, 11, 5, 2) X(V, 12, 5, 3) X(V, 13, 5, 4)             \
    X(V, 14, 5, 5) X(V, 15, 6, 1) X(V, 16, 6, 2) X(V, 17, 6, 3) X(V, 18, 6, 4) X(V, 19, 6, 5) X(V, 20, 6, 6)          \
    X(V, 21, 7, 1) X(V, 22, 7, 2) X(V, 23, 7, 3) X(V, 24, 7, 4) X(V, 25, 7, 5) X(V, 26, 7, 6) X(V, 27, 7, 7)          \
    X(V, 28, 8, 1) X(V, 29, 8, 2) X(V, 30, 8, 3) X(V, 31, 8, 5) X(V, 32, 8, 6) X(V, 33, 8, 7) X(V, 34, 8, 8)          \
    X(V, 35, 9, 1) X(V, 36, 9, 3) X(V, 37, 9, 4) X(V, 38, 9, 5) X(V, 39, 9, 6) X(V, 40, 9, 7) X(V, 41, 9, 8)          \
    X(V, 42, 9, 9) X(V, 43, 10, 1) X(V, 44, 10, 2) X(V, 45, 10, 3) X(V, 46, 10, 4) X(V, 47, 10, 5)                    \
    X(V, 48, 10, 7) X(V, 49, 10, 9) X(V, 50, 11, 1) X(V, 51, 11, 2) X(V, 52, 11, 3) X(V, 53, 11, 4)                   \
    X(V, 54, 11, 5) X(V, 55, 11, 6) X(V, 56, 11, 7) X(V, 57, 11, 8) X(V, 58, 11, 9) X(V, 59, 11, 10)                  \
    X(V, 60, 11, 11) X(V, 61, 12, 1) X(V, 62, 12, 2) X(V, 63, 12, 3) X(V, 64, 12, 4) X(V, 65, 12, 5)                  \
    X(V, 66, 12, 6) X(V, 67, 12, 7) X(V, 68, 12, 8) X(V, 69, 12, 10) X(V, 70, 12, 11) X(V, 71, 12, 12)                \
    X(V, 72, 13, 1) X(V, 73, 13, 2) X(V, 74, 13, 3) X(V, 75, 13, 4) X(V, 76, 13, 5) X(V, 77, 13, 6)                   \
    X(V, 78, 13, 7) X(V, 79, 13, 8) X(V, 80, 13, 9) X(V, 81, 13, 10) X(V, 82, 13, 11) X(V, 83, 13, 12)                \
    X(V, 84, 13, 13) X(V, 85, 14, 1) X(V, 86, 14, 2) X(V, 87, 14, 3) X(V, 88, 14, 5) X(V, 89, 14, 7)                  \
    X(V, 90, 14, 8) X(V, 91, 14, 9) X(V, 92, 14, 11) X(V, 93, 14, 12) X(V, 94, 14, 13) X(V, 95, 15, 1)                \
    X(V, 96, 15, 3) X(V, 97, 15, 4) X(V, 98, 15, 5) X(V, 99, 15, 6) X(V, 100, 15, 7) X(V, 101, 15, 8)                 \
    X(V, 102, 15, 10) X(V, 103, 15, 11) X(V, 104, 15, 13) X(V, 105, 15, 14) X(V, 106, 15, 15)
#define SFIELD__TERMS4(X, V)                                                                                          \
    X(V, 0, 1, 8) X(V, 1, 1, 11) X(V, 2, 1, 15) X(V, 3, 1, 28) X(V, 4, 1, 41) X(V, 5, 1, 48) X(V, 6, 1, 55)           \
    X(V, 7, 1, 57) X(V, 8, 1, 65) X(V, 9, 1, 75) X(V, 10, 1, 88) X(V, 11, 1, 97) X(V, 12, 2, 10) X(V, 13, 2, 16)      \
    X(V, 14, 2, 23) X(V, 15, 2, 46) X(V, 16, 2, 54) X(V, 17, 2, 66) X(V, 18, 2, 78) X(V, 19, 2, 90)                   \
    X(V, 20, 3, 6) X(V, 21, 3, 17) X(V, 22, 3, 22) X(V, 23, 3, 30) X(V, 24, 3, 37) X(V, 25, 3, 47)                    \
    X(V, 26, 3, 53) X(V, 27, 3, 67) X(V, 28, 3, 77) X(V, 29, 3, 79) X(V, 30, 3, 89) X(V, 31, 3, 101)                  \
    X(V, 32, 4, 3) X(V, 33, 4, 18) X(V, 34, 4, 25) X(V, 35, 4, 36) X(V, 36, 4, 44) X(V, 37, 4, 52)                    \
    X(V, 38, 4, 69) X(V, 39, 4, 72) X(V, 40, 4, 80) X(V, 41, 4, 82) X(V, 42, 4, 95) X(V, 43, 4, 103)                  \
    X(V, 44, 5, 1) X(V, 45, 5, 19) X(V, 46, 5, 24) X(V, 47, 5, 31) X(V, 48, 5, 45) X(V, 49, 5, 51)                    \
    X(V, 50, 5, 61) X(V, 51, 5, 70) X(V, 52, 5, 81) X(V, 53, 5, 85) X(V, 54, 5, 91) X(V, 55, 5, 92)                   \
    X(V, 56, 5, 102) X(V, 57, 6, 0) X(V, 58, 6, 2) X(V, 59, 6, 5) X(V, 60, 6, 9) X(V, 61, 6, 14) X(V, 62, 6, 20)      \
    X(V, 63, 6, 27) X(V, 64, 6, 34) X(V, 65, 6, 42) X(V, 66, 6, 50) X(V, 67, 6, 60) X(V, 68, 6, 62)                   \
    X(V, 69, 6, 71) X(V, 70, 6, 74) X(V, 71, 6, 84) X(V, 72, 6, 106) X(V, 73, 7, 4) X(V, 74, 7, 13)                   \
    X(V, 75, 7, 26) X(V, 76, 7, 33) X(V, 77, 7, 43) X(V, 78, 7, 49) X(V, 79, 7, 59) X(V, 80, 7, 63)                   \
    X(V, 81, 7, 73) X(V, 82, 7, 83) X(V, 83, 7, 87) X(V, 84, 7, 94) X(V, 85, 7, 105) X(V, 86, 8, 0)                   \
    X(V, 87, 8, 5) X(V, 88, 8, 14) X(V, 89, 8, 27) X(V, 90, 8, 32) X(V, 91, 8, 35) X(V, 92, 8, 50)                    \
    X(V, 93, 8, 58) X(V, 94, 8, 60) X(V, 95, 8, 74) X(V, 96, 8, 84) X(V, 97, 8, 86) X(V, 98, 8, 93)                   \
    X(V, 99, 8, 96) X(V, 100, 8, 104) X(V, 101, 9, 8) X(V, 102, 9, 28) X(V, 103, 9, 39) X(V, 104, 9, 48)              \
    X(V, 105, 9, 57) X(V, 106, 9, 75) X(V, 107, 9, 88) X(V, 108, 10, 7) X(V, 109, 10, 12) X(V, 110, 10, 21)           \
    X(V, 111, 10, 40) X(V, 112, 10, 56) X(V, 113, 10, 64) X(V, 114, 10, 76) X(V, 115, 10, 98) X(V, 116, 11, 8)        \
    X(V, 117, 11, 11) X(V, 118, 11, 15) X(V, 119, 11, 28) X(V, 120, 11, 41) X(V, 121, 11, 48) X(V, 122, 11, 55)       \
    X(V, 123, 11, 57) X(V, 124, 11, 65) X(V, 125, 11, 75) X(V, 126, 11, 88) X(V, 127, 11, 97) X(V, 128, 12, 10)       \
    X(V, 129, 12, 16) X(V, 130, 12, 23) X(V, 131, 12, 46) X(V, 132, 12, 54) X(V, 133, 12, 66) X(V, 134, 12, 78)       \
    X(V, 135, 12, 90) X(V, 136, 13, 6) X(V, 137, 13, 17) X(V, 138, 13, 22) X(V, 139, 13, 30) X(V, 140, 13, 37)        \
    X(V, 141, 13, 47) X(V, 142, 13, 53) X(V, 143, 13, 67) X(V, 144, 13, 77) X(V, 145, 13, 79) X(V, 146, 13, 89)       \
    X(V, 147, 13, 101) X(V, 148, 14, 10) X(V, 149, 14, 23) X(V, 150, 14, 29) X(V, 151, 14, 38) X(V, 152, 14, 54)      \
    X(V, 153, 14, 68) X(V, 154, 14, 78) X(V, 155, 14, 100) X(V, 156, 15, 6) X(V, 157, 15, 30) X(V, 158, 15, 47)       \
    X(V, 159, 15, 53) X(V, 160, 15, 79) X(V, 161, 15, 89) X(V, 162, 15, 99)

#define SFIELD__PAIR4(V, q, i, j)                                                                                      \
    sfield__##V p##q = sfield__##V##_mul(sfield__##V##_load(a + i * stride), sfield__##V##_load(b + j * stride));      \
    if (i != j)                                                                                                        \
        p##q = sfield__##V##_fma(sfield__##V##_load(b + i * stride), sfield__##V##_load(a + j * stride), p##q);

#define SFIELD__TERM4(V, e, k, q) r[k] = sfield__##V##_fma(sfield__##V##_set1(c[e].c), p##q, r[k]);

#define SFIELD__KERNEL4(V, TARGET)                                                                                     \
    TARGET static void sfield__product4_##V(const sfield_algebra *t, const float *a, const float *b, float *out,       \
                                            size_t stride, int occlude)                                                \
    {                                                                                                                  \
        const sfield__entry *c = t->entry;                                                                             \
        sfield__##V r[16], a0, b0, acc;                                                                                \
        uint32_t k;                                                                                                    \
        acc = sfield__##V##_mul(sfield__##V##_load(a), sfield__##V##_load(b));                                         \
        a0 = sfield__##V##_mul(sfield__##V##_load(a), sfield__##V##_set1(sfield__y00));                                \
        b0 = sfield__##V##_mul(sfield__##V##_load(b), sfield__##V##_set1(sfield__y00));                                \
        for (k = 1; k < 16; k++) {                                                                                     \
            acc = sfield__##V##_fma(sfield__##V##_load(a + k * stride), sfield__##V##_load(b + k * stride), acc);      \
            r[k] = sfield__##V##_mul(a0, sfield__##V##_load(b + k * stride));                                          \
            r[k] = sfield__##V##_fma(b0, sfield__##V##_load(a + k * stride), r[k]);                                    \
        }                                                                                                              \
        r[0] = sfield__##V##_mul(acc, sfield__##V##_set1(sfield__y00));                                                \
        {                                                                                                              \
            SFIELD__PAIRS4(SFIELD__PAIR4, V)                                                                           \
            SFIELD__TERMS4(SFIELD__TERM4, V)                                                                           \
        }                                                                                                              \
        for (k = 0; k < 16; k++) {                                                                                     \
            acc = occlude ? sfield__##V##_sub(sfield__##V##_load(a + k * stride), r[k]) : r[k];                        \
            sfield__##V##_store(out + k * stride, acc);                                                                \
        }                                                                                                              \
    }

/* Rotations likewise, in bands of 3, 5 and 7: rows of a block by what registers hold. m: the row; s: its stride. */
#define SFIELD__HOLD(V, x) sfield__##V##_load(from + x * stride)

#define SFIELD__ROW3(V, m, s)                                                                                          \
    sfield__##V##_fma(                                                                                                 \
        sfield__##V##_set1((m)[2 * (s)]), x2,                                                                          \
        sfield__##V##_fma(sfield__##V##_set1((m)[s]), x1, sfield__##V##_mul(sfield__##V##_set1((m)[0]), x0)))

#define SFIELD__ROW5(V, m, s)                                                                                          \
    sfield__##V##_fma(sfield__##V##_set1((m)[4 * (s)]), x4,                                                            \
                      sfield__##V##_fma(sfield__##V##_set1((m)[3 * (s)]), x3, SFIELD__ROW3(V, m, s)))

#define SFIELD__ROW7(V, m, s)                                                                                          \
    sfield__##V##_fma(sfield__##V##_set1((m)[6 * (s)]), x6,                                                            \
                      sfield__##V##_fma(sfield__##V##_set1((m)[5 * (s)]), x5, SFIELD__ROW5(V, m, s)))

#define SFIELD__ROTATE4(V, TARGET)                                                                                     \
    TARGET static void sfield__rotate4_##V(const sfield_rotation *rotation, const float *in, float *out, size_t stride,\
                                           int inverse)                                                                \
    {                                                                                                                  \
        const float *m = rotation->block, *from = in;                                                                  \
        sfield__##V x0, x1, x2, x3, x4, x5, x6;                                                                        \
        uint32_t y;                                                                                                    \
        sfield__##V##_store(out, sfield__##V##_mul(sfield__##V##_set1(m[0]), SFIELD__HOLD(V, 0)));                     \
        m += 1;                                                                                                        \
        from = in + stride;                                                                                            \
        x0 = SFIELD__HOLD(V, 0), x1 = SFIELD__HOLD(V, 1), x2 = SFIELD__HOLD(V, 2);                                     \
        for (y = 0; y < 3; y++)                                                                                        \
            sfield__##V##_store(out + (1 + y) * stride, SFIELD__ROW3(V, m + y * (inverse ? 1 : 3), inverse ? 3 : 1));  \
        m += 9;                                                                                                        \
        from = in + 4 * stride;                                                                                        \
        x0 = SFIELD__HOLD(V, 0), x1 = SFIELD__HOLD(V, 1), x2 = SFIELD__HOLD(V, 2), x3 = SFIELD__HOLD(V, 3);            \
        x4 = SFIELD__HOLD(V, 4);                                                                                       \
        for (y = 0; y < 5; y++)                                                                                        \
            sfield__##V##_store(out + (4 + y) * stride, SFIELD__ROW5(V, m + y * (inverse ? 1 : 5), inverse ? 5 : 1));  \
        m += 25;                                                                                                       \
        from = in + 9 * stride;                                                                                        \
        x0 = SFIELD__HOLD(V, 0), x1 = SFIELD__HOLD(V, 1), x2 = SFIELD__HOLD(V, 2), x3 = SFIELD__HOLD(V, 3);            \
        x4 = SFIELD__HOLD(V, 4), x5 = SFIELD__HOLD(V, 5), x6 = SFIELD__HOLD(V, 6);                                     \
        for (y = 0; y < 7; y++)                                                                                        \
            sfield__##V##_store(out + (9 + y) * stride, SFIELD__ROW7(V, m + y * (inverse ? 1 : 7), inverse ? 7 : 1));  \
    }

#if defined(__GNUC__) && !defined(__TINYC__)
typedef float sfield__f4 __attribute__((vector_size(16)));
typedef struct sfield__plain { sfield__f4 a, b, c, d; } sfield__plain;
#define SFIELD__EACH(op) r.a = op(a), r.b = op(b), r.c = op(c), r.d = op(d)
#else
typedef struct sfield__plain { float v[16]; } sfield__plain;
#endif

#ifdef SFIELD__EACH
/* Four by four: as a whole, gcc brings it through memory. */
SFIELD__INLINE sfield__plain sfield__plain_load(const float *p)
{
    sfield__plain r;
    memcpy(&r.a, p, sizeof r.a);
    memcpy(&r.b, p + 4, sizeof r.b);
    memcpy(&r.c, p + 8, sizeof r.c);
    memcpy(&r.d, p + 12, sizeof r.d);
    return r;
}
SFIELD__INLINE void sfield__plain_store(float *p, sfield__plain x)
{
    memcpy(p, &x.a, sizeof x.a);
    memcpy(p + 4, &x.b, sizeof x.b);
    memcpy(p + 8, &x.c, sizeof x.c);
    memcpy(p + 12, &x.d, sizeof x.d);
}
SFIELD__INLINE sfield__plain sfield__plain_set1(float x)
{
    const sfield__f4 all = { x, x, x, x };
    sfield__plain r;
    r.a = r.b = r.c = r.d = all;
    return r;
}
SFIELD__INLINE sfield__plain sfield__plain_mul(sfield__plain x, sfield__plain y)
{
    sfield__plain r;
#define SFIELD__OP(m) x.m * y.m
    SFIELD__EACH(SFIELD__OP);
#undef SFIELD__OP
    return r;
}
SFIELD__INLINE sfield__plain sfield__plain_fma(sfield__plain x, sfield__plain y, sfield__plain z)
{
    sfield__plain r;
#define SFIELD__OP(m) x.m * y.m + z.m
    SFIELD__EACH(SFIELD__OP);
#undef SFIELD__OP
    return r;
}
SFIELD__INLINE sfield__plain sfield__plain_sub(sfield__plain x, sfield__plain y)
{
    sfield__plain r;
#define SFIELD__OP(m) x.m - y.m
    SFIELD__EACH(SFIELD__OP);
#undef SFIELD__OP
    return r;
}
SFIELD__INLINE sfield__plain sfield__plain_add(sfield__plain x, sfield__plain y)
{
    sfield__plain r;
#define SFIELD__OP(m) x.m + y.m
    SFIELD__EACH(SFIELD__OP);
#undef SFIELD__OP
    return r;
}
#undef SFIELD__EACH
#else
SFIELD__INLINE sfield__plain sfield__plain_load(const float *p)
{
    sfield__plain r;
    memcpy(&r, p, sizeof r);
    return r;
}
SFIELD__INLINE void sfield__plain_store(float *p, sfield__plain x) { memcpy(p, &x, sizeof x); }
SFIELD__INLINE sfield__plain sfield__plain_set1(float x)
{
    sfield__plain r;
    int i;
    for (i = 0; i < 16; i++) r.v[i] = x;
    return r;
}
SFIELD__INLINE sfield__plain sfield__plain_fma(sfield__plain x, sfield__plain y, sfield__plain z)
{
    int i;
    for (i = 0; i < 16; i++) z.v[i] += x.v[i] * y.v[i];
    return z;
}
SFIELD__INLINE sfield__plain sfield__plain_mul(sfield__plain x, sfield__plain y)
{
    int i;
    for (i = 0; i < 16; i++) x.v[i] *= y.v[i];
    return x;
}
SFIELD__INLINE sfield__plain sfield__plain_sub(sfield__plain x, sfield__plain y)
{
    int i;
    for (i = 0; i < 16; i++) x.v[i] -= y.v[i];
    return x;
}
SFIELD__INLINE sfield__plain sfield__plain_add(sfield__plain x, sfield__plain y)
{
    int i;
    for (i = 0; i < 16; i++) x.v[i] += y.v[i];
    return x;
}
#endif
/* max(0, x) */
SFIELD__INLINE sfield__plain sfield__plain_positive(sfield__plain x)
{
    float v[16];
    int i;
    memcpy(v, &x, sizeof v);
    for (i = 0; i < 16; i++) v[i] = v[i] > 0 ? v[i] : 0.0f;
    memcpy(&x, v, sizeof v);
    return x;
}
/* Is any lane not 0? */
SFIELD__INLINE int sfield__plain_any(sfield__plain x)
{
    float v[16];
    int i, any = 0;
    memcpy(v, &x, sizeof v);
    for (i = 0; i < 16; i++) any |= v[i] != 0;
    return any;
}
SFIELD__KERNELS(plain, )
SFIELD__ROTATE4(plain, )

#if SFIELD__SIMD
typedef struct sfield__avx2 { __m256 lo, hi; } sfield__avx2;
SFIELD__TARGET_AVX2 SFIELD__INLINE sfield__avx2 sfield__avx2_make(__m256 lo, __m256 hi)
{
    sfield__avx2 r;
    r.lo = lo;
    r.hi = hi;
    return r;
}
SFIELD__TARGET_AVX2 SFIELD__INLINE sfield__avx2 sfield__avx2_load(const float *p)
{
    return sfield__avx2_make(_mm256_loadu_ps(p), _mm256_loadu_ps(p + 8));
}
SFIELD__TARGET_AVX2 SFIELD__INLINE void sfield__avx2_store(float *p, sfield__avx2 x)
{
    _mm256_storeu_ps(p, x.lo);
    _mm256_storeu_ps(p + 8, x.hi);
}
SFIELD__TARGET_AVX2 SFIELD__INLINE sfield__avx2 sfield__avx2_set1(float x)
{
    return sfield__avx2_make(_mm256_set1_ps(x), _mm256_set1_ps(x));
}
SFIELD__TARGET_AVX2 SFIELD__INLINE sfield__avx2 sfield__avx2_mul(sfield__avx2 x, sfield__avx2 y)
{
    return sfield__avx2_make(_mm256_mul_ps(x.lo, y.lo), _mm256_mul_ps(x.hi, y.hi));
}
SFIELD__TARGET_AVX2 SFIELD__INLINE sfield__avx2 sfield__avx2_sub(sfield__avx2 x, sfield__avx2 y)
{
    return sfield__avx2_make(_mm256_sub_ps(x.lo, y.lo), _mm256_sub_ps(x.hi, y.hi));
}
SFIELD__TARGET_AVX2 SFIELD__INLINE sfield__avx2 sfield__avx2_add(sfield__avx2 x, sfield__avx2 y)
{
    return sfield__avx2_make(_mm256_add_ps(x.lo, y.lo), _mm256_add_ps(x.hi, y.hi));
}
SFIELD__TARGET_AVX2 SFIELD__INLINE sfield__avx2 sfield__avx2_positive(sfield__avx2 x)
{
    return sfield__avx2_make(_mm256_max_ps(x.lo, _mm256_setzero_ps()), _mm256_max_ps(x.hi, _mm256_setzero_ps()));
}
SFIELD__TARGET_AVX2 SFIELD__INLINE int sfield__avx2_any(sfield__avx2 x)
{
    const __m256 both = _mm256_or_ps(x.lo, x.hi);
    return _mm256_movemask_ps(_mm256_cmp_ps(both, _mm256_setzero_ps(), _CMP_NEQ_UQ)) != 0;
}
SFIELD__TARGET_AVX2 SFIELD__INLINE sfield__avx2 sfield__avx2_fma(sfield__avx2 x, sfield__avx2 y, sfield__avx2 z)
{
    return sfield__avx2_make(_mm256_fmadd_ps(x.lo, y.lo, z.lo), _mm256_fmadd_ps(x.hi, y.hi, z.hi));
}
SFIELD__KERNELS(avx2, SFIELD__TARGET_AVX2)
SFIELD__KERNEL4(avx2, SFIELD__TARGET_AVX2)
SFIELD__ROTATE4(avx2, SFIELD__TARGET_AVX2)

typedef __m512 sfield__avx512;
SFIELD__TARGET_AVX512 SFIELD__INLINE __m512 sfield__avx512_load(const float *p) { return _mm512_loadu_ps(p); }
SFIELD__TARGET_AVX512 SFIELD__INLINE void sfield__avx512_store(float *p, __m512 x) { _mm512_storeu_ps(p, x); }
SFIELD__TARGET_AVX512 SFIELD__INLINE __m512 sfield__avx512_set1(float x) { return _mm512_set1_ps(x); }
SFIELD__TARGET_AVX512 SFIELD__INLINE __m512 sfield__avx512_mul(__m512 x, __m512 y) { return _mm512_mul_ps(x, y); }
SFIELD__TARGET_AVX512 SFIELD__INLINE __m512 sfield__avx512_sub(__m512 x, __m512 y) { return _mm512_sub_ps(x, y); }
SFIELD__TARGET_AVX512 SFIELD__INLINE __m512 sfield__avx512_add(__m512 x, __m512 y) { return _mm512_add_ps(x, y); }
SFIELD__TARGET_AVX512 SFIELD__INLINE __m512 sfield__avx512_positive(__m512 x)
{
    return _mm512_maskz_max_ps((__mmask16)0xffff, x, _mm512_setzero_ps());     /* gcc 12's own warns of itself */
}
SFIELD__TARGET_AVX512 SFIELD__INLINE int sfield__avx512_any(__m512 x)
{
    return _mm512_cmp_ps_mask(x, _mm512_setzero_ps(), _CMP_NEQ_UQ) != 0;
}
SFIELD__TARGET_AVX512 SFIELD__INLINE __m512 sfield__avx512_fma(__m512 x, __m512 y, __m512 z)
{
    return _mm512_fmadd_ps(x, y, z);
}
SFIELD__KERNELS(avx512, SFIELD__TARGET_AVX512)
SFIELD__KERNEL4(avx512, SFIELD__TARGET_AVX512)
SFIELD__ROTATE4(avx512, SFIELD__TARGET_AVX512)
#endif
#undef SFIELD__KERNELS

static int sfield__simd(void)
{
    return !SFIELD__SIMD || !sfield__cpu_has_avx2() ? 0 : sfield__cpu_has_avx512() ? 2 : 1;
}

/* 16 lanes: out = a b, or with occlude a - a b. */
static void sfield__product16(const sfield_algebra *t, const float *a, const float *b, float *out, size_t stride,
                              int occlude)
{
#if SFIELD__SIMD
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

static void sfield__rotate16(const sfield_rotation *r, const float *in, float *out, size_t stride, int inverse,
                             int simd)
{
#if SFIELD__SIMD
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

/* ---- >>harmonics ---- */

static const double sfield__pi = 3.14159265358979323846;

/* In double and with the same bits everywhere; |x| <= 2 pi. Taylor on |r| <= pi / 4 is exact to the last bits. */
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

/* Normalised associated Legendre functions without their power of sin(theta), which goes with cos and sin of m phi into
   the polynomials cm + i sm = (x + i y)^m. No Condon-Shortley sign. */
SFIELD_DEF void sfield_sh_basis(uint32_t bands, const double direction[3], double *y)
{
    double z = direction[2], cm = 1, sm = 0, older, diagonal = 0.28209479177387814347;
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

/* Gauss-Legendre in z times equal steps in phi: exact for polynomials up to degree. x, y, z, weight. */
static void sfield__grid(uint32_t degree, double *node)
{
    uint32_t n = degree / 2 + 1, m = degree + 1, i, j, step;
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

static int sfield__may_triple(uint32_t i, uint32_t j, uint32_t k)
{
    uint32_t a = 0, b = 0, c = 0;
    while ((a + 1) * (a + 1) <= i) a++;
    while ((b + 1) * (b + 1) <= j) b++;
    while ((c + 1) * (c + 1) <= k) c++;
    return (a + b + c) % 2 == 0 && a + b >= c && a + c >= b && b + c >= a;
}

/* Fills pairs and entries from the values at the nodes of a grid of degree 3 (n - 1). table: coefs floats a pair. */
static uint32_t sfield__tripling(sfield_algebra *t, const double *basis, const double *node, size_t nodes,
                                 double *product, float *table)
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
                for (g = 0; sfield__may_triple(i, j, k) && g < nodes; g++) sum += product[g] * basis[g * t->coefs + k];
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

static void sfield__basis_at(const double *node, size_t nodes, uint32_t bands, double *basis)
{
    size_t g;
    for (g = 0; g < nodes; g++) sfield_sh_basis(bands, node + 4 * g, basis + g * bands * bands);
}

static sfield_result sfield__algebra_fill(sfield_algebra *t, double *work, size_t nodes)
{
    uint32_t pairs = t->coefs * (t->coefs - 1) / 2, entries;
    double *node = work, *basis = node + 4 * nodes, *product = basis + nodes * t->coefs;
    float *table = (float *)(void *)(product + nodes);
    size_t g, k;
    uint8_t *at;
    sfield__grid(3 * (t->bands - 1), node);
    sfield__basis_at(node, nodes, t->bands, basis);
    t->pair = (uint8_t *)(table + (size_t)pairs * t->coefs);
    t->pair_i = t->pair + pairs;
    entries = sfield__tripling(t, basis, node, nodes, product, table);
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
    sfield__grid(2 * (t->bands - 1), t->node);
    sfield__basis_at(t->node, t->node_count, t->bands, t->basis);
    for (g = 0; g < t->node_count; g++)
        for (k = 0; k < t->coefs; k++) t->basis[g * t->coefs + k] *= t->node[4 * g + 3];
    return SFIELD_OK;
}

static sfield__allocator sfield__allocator_of(const sfield_allocator *a)
{
    return a ? sfield__allocator_make(a->alloc_fn, a->free_fn, a->user) : sfield__allocator_make(NULL, NULL, NULL);
}

SFIELD_DEF sfield_result sfield_algebra_create(uint32_t bands, const sfield_allocator *allocator, sfield_algebra **out)
{
    sfield__allocator a = sfield__allocator_of(allocator);
    sfield_algebra *t;
    sfield_result result;
    double *work;
    size_t nodes, pairs;
    if (!out || bands < 1 || bands > SFIELD_MAX_BANDS) return SFIELD_ERR_ARGUMENT;
    if (allocator && !sfield__allocator_valid(allocator->alloc_fn, allocator->free_fn)) return SFIELD_ERR_ARGUMENT;
    t = (sfield_algebra *)sfield__alloc(&a, sizeof *t);
    if (!t) return SFIELD_ERR_ALLOC;
    memset(t, 0, sizeof *t);
    t->allocator = a;
    t->bands = bands;
    t->coefs = bands * bands;
    t->simd = sfield__simd();
    nodes = sfield__grid_size(3 * (bands - 1));
    pairs = (size_t)t->coefs * (t->coefs - 1) / 2;
    work = (double *)sfield__alloc(&a, nodes * (t->coefs + 5) * sizeof *work + pairs * (t->coefs * sizeof(float) + 2));
    result = work ? sfield__algebra_fill(t, work, nodes) : SFIELD_ERR_ALLOC;
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

/* Planes of `count` vectors, fewer than 16, to and from a tile; missing lanes are 0. */
static void sfield__tile_in(uint32_t coefs, size_t count, const float *in, size_t stride, float *tile)
{
    size_t k, i;
    for (k = 0; k < coefs; k++)
        for (i = 0; i < SFIELD__LANES; i++) tile[k * SFIELD__LANES + i] = i < count ? in[k * stride + i] : 0.0f;
}

static void sfield__tile_out(uint32_t coefs, size_t count, const float *tile, float *out, size_t stride)
{
    size_t k, i;
    for (k = 0; k < coefs; k++)
        for (i = 0; i < count; i++) out[k * stride + i] = tile[k * SFIELD__LANES + i];
}

SFIELD_DEF sfield_result sfield_sh_product(const sfield_algebra *t, size_t count, const float *a, const float *b,
                                           float *out, size_t stride)
{
    float tile[2][SFIELD_MAX_COEFS * SFIELD__LANES] = { { 0 } };
    size_t i;
    if (!t || !a || !b || !out || stride < count) return SFIELD_ERR_ARGUMENT;
    for (i = 0; i + SFIELD__LANES <= count; i += SFIELD__LANES) sfield__product16(t, a + i, b + i, out + i, stride, 0);
    if (i == count) return SFIELD_OK;
    sfield__tile_in(t->coefs, count - i, a + i, stride, tile[0]);
    sfield__tile_in(t->coefs, count - i, b + i, stride, tile[1]);
    sfield__product16(t, tile[0], tile[1], tile[0], SFIELD__LANES, 0);
    sfield__tile_out(t->coefs, count - i, tile[0], out + i, stride);
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

SFIELD_DEF sfield_result sfield_sh_dot(uint32_t bands, size_t count, const float *a, const float *b, float *out,
                                       size_t stride)
{
    size_t i, j, n, k;
    if (bands < 1 || bands > SFIELD_MAX_BANDS || !a || !b || !out || stride < count) return SFIELD_ERR_ARGUMENT;
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

/* Is a rotation times a scale no rotation? Asked of zeros, since a diagonal divided by its mean length may miss 1. */
static int sfield__is_upright(const float *m)
{
    return m[1] == 0 && m[2] == 0 && m[4] == 0 && m[6] == 0 && m[8] == 0 && m[9] == 0 && m[0] > 0 && m[5] > 0;
}

SFIELD_DEF sfield_result sfield_sh_rotation(const sfield_algebra *t, const float matrix[16], sfield_rotation *out)
{
    double sum[680], y[SFIELD_MAX_COEFS], *s;
    const double *basis;
    float scale, *block;
    uint32_t g, l, i, j;
    if (!t || !matrix || !out || !sfield__m4_is_rigid_uniform(matrix, &scale)) return SFIELD_ERR_ARGUMENT;
    memset(sum, 0, sizeof sum);
    for (g = 0; g < t->node_count; g++) {
        const double *d = t->node + 4 * (size_t)g;
        double back[3], length;
        for (i = 0; i < 3; i++)
            back[i] =
                (double)matrix[4 * i] * d[0] + (double)matrix[4 * i + 1] * d[1] + (double)matrix[4 * i + 2] * d[2];
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
            for (j = 0; j < 2 * l + 1; j++, s++) *block++ = out->identity ? (i == j ? 1.0f : 0.0f) : (float)*s;
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_sh_rotate(const sfield_rotation *r, size_t count, const float *in, float *out,
                                          size_t stride)
{
    float tile[SFIELD_MAX_COEFS * SFIELD__LANES] = { 0 };
    int simd = sfield__simd();
    uint32_t coefs;
    size_t i;
    if (!r || !in || !out || stride < count || r->bands < 1 || r->bands > SFIELD_MAX_BANDS) return SFIELD_ERR_ARGUMENT;
    coefs = r->bands * r->bands;
    for (i = 0; i + SFIELD__LANES <= count; i += SFIELD__LANES) sfield__rotate16(r, in + i, out + i, stride, 0, simd);
    if (i == count) return SFIELD_OK;
    sfield__tile_in(coefs, count - i, in + i, stride, tile);
    sfield__rotate16(r, tile, tile, SFIELD__LANES, 0, simd);
    sfield__tile_out(coefs, count - i, tile, out + i, stride);
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_sh_product_n(uint32_t bands, uint32_t functions, const float *coefs,
                                             const sfield_allocator *allocator, double *out)
{
    sfield__allocator a = sfield__allocator_of(allocator);
    double y[SFIELD_MAX_COEFS], sum[SFIELD_MAX_COEFS], *node;
    uint32_t n = bands * bands, f, k;
    size_t nodes, g;
    if (bands < 1 || bands > SFIELD_MAX_BANDS || functions < 1 || functions > 32 || !coefs || !out)
        return SFIELD_ERR_ARGUMENT;
    if (allocator && !sfield__allocator_valid(allocator->alloc_fn, allocator->free_fn)) return SFIELD_ERR_ARGUMENT;
    nodes = sfield__grid_size((functions + 1) * (bands - 1));
    node = (double *)sfield__alloc_array(&a, nodes, 4 * sizeof *node);
    if (!node) return SFIELD_ERR_ALLOC;
    sfield__grid((functions + 1) * (bands - 1), node);
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

/* ---- >>logarithms (Ren et al., "Real-time soft shadows in dynamic scenes using spherical harmonic exponentiation",
   SIGGRAPH 2006) ---- */

/* One Jacobi rotation of the symmetric matrix m and of the vectors v, n x n each. */
static void sfield__jacobi(double *m, double *v, uint32_t n, uint32_t p, uint32_t q)
{
    double off = m[p * n + q], theta, t, c, s;
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

/* log f = V^T log(D) V 1, where V^T D V is the matrix that multiplies by f. work: 2 n^2 doubles, n coefficients. */
static void sfield__sh_log(const sfield_algebra *t, const float *f, float *out, double *work)
{
    uint32_t n = t->coefs, i, j, k, q, sweep;
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
    double *work;
    if (!t || !visibility || !out) return SFIELD_ERR_ARGUMENT;
    work = (double *)sfield__alloc_array(&t->allocator, 2 * (size_t)t->coefs * t->coefs, sizeof *work);
    if (!work) return SFIELD_ERR_ALLOC;
    sfield__sh_log(t, visibility, out, work);
    sfield__free(&t->allocator, work);
    return SFIELD_OK;
}

/* A tile: the constant apart, then exp(h) = (1 + h/s + (h/s)^2/2 + (h/s)^3/6)^s with s a power of two so that |h/s| is
   small. out may be in. */
static void sfield__exp16(const sfield_algebra *t, const float *in, float *out)
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
    size_t i, n;
    if (!t || !in || !out || stride < count) return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < count; i += n) {
        n = count - i < SFIELD__LANES ? count - i : (size_t)SFIELD__LANES;
        sfield__tile_in(t->coefs, n, in + i, stride, tile);
        sfield__exp16(t, tile, tile);
        sfield__tile_out(t->coefs, n, tile, out + i, stride);
    }
    return SFIELD_OK;
}

/* ---- windows and kernels ---- */

SFIELD_DEF void sfield_sh_window(uint32_t bands, float strength, float factors[SFIELD_MAX_BANDS])
{
    uint32_t l;
    for (l = 0; l < bands && l < SFIELD_MAX_BANDS; l++)
        factors[l] = 1.0f / (1.0f + strength * (float)(l * l * (l + 1) * (l + 1)));
}

SFIELD_DEF float sfield_sh_window_fit(uint32_t bands, const float *coefs, float lowest)
{
    float low = 0, high = 1, strength = 0;
    uint32_t step, i, j, k, l;
    if (!coefs || bands < 1 || bands > SFIELD_MAX_BANDS) return 0;
    for (step = 0; step < 20; step++) {         /* the first try is no window at all */
        float factors[SFIELD_MAX_BANDS];
        int good = 1;
        sfield_sh_window(bands, strength, factors);
        for (i = 0; i < 36 && good; i++)
            for (j = 0; j < 72 && good; j++) {
                double d[3], y[SFIELD_MAX_COEFS], value = 0, s, c, ring;
                sfield__sincos_d(sfield__pi * i / 35, &ring, &d[2]);
                sfield__sincos_d(sfield__pi * j / 36, &s, &c);
                d[0] = ring * c;
                d[1] = ring * s;
                sfield_sh_basis(bands, d, y);
                for (l = 0, k = 0; l < bands; l++)
                    for (; k < (l + 1) * (l + 1); k++) value += (double)(factors[l] * coefs[k]) * y[k];
                good = value >= (double)lowest;
            }
        if (good && strength == 0) return 0;
        if (good) high = strength;
        else low = strength;
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

/* ---- >>cubes ---- */

/* Faces in OpenGL's order: a direction's components along the face's s, t and its axis. */
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

static uint32_t sfield__texel(uint32_t side, uint32_t face, uint32_t x, uint32_t y)
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

/* The 16 Gauss-Legendre points of a texel: unit direction and weight, whose sum is the solid angle to
   double precision. */
static void sfield__texel_points(uint32_t side, uint32_t texel, double points[16][4])
{
    static const double at[4] = { -0.86113631159405257522, -0.33998104358485626480, 0.33998104358485626480,
                                  0.86113631159405257522 };
    static const double weight[4] = { 0.34785484513745385737, 0.65214515486254614263, 0.65214515486254614263,
                                      0.34785484513745385737 };
    uint32_t face, x, y, i, j;
    sfield__texel_place(side, texel, &face, &x, &y);
    for (j = 0; j < 4; j++)
        for (i = 0; i < 4; i++) {
            double *p = points[4 * j + i], s = (2.0 * x + 1 + at[i]) / side - 1, t = (2.0 * y + 1 + at[j]) / side - 1;
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
    return sfield__texel(side, face, x < side ? x : side - 1, y < side ? y : side - 1);
}

/* Integral of every basis function over one texel. */
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
    if (bands < 1 || bands > SFIELD_MAX_BANDS || !sfield__is_side(side, 2) || texel >= 6 * side * side || !out)
        return SFIELD_ERR_ARGUMENT;
    sfield__texel_basis(bands, side, texel, out);
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_sh_project(uint32_t bands, uint32_t side, const float *texels, uint32_t channels,
                                           float *coefs)
{
    double sum[3 * SFIELD_MAX_COEFS] = { 0 };
    float y[SFIELD_MAX_COEFS];
    uint32_t n = bands * bands, i, k, c;
    if (bands < 1 || bands > SFIELD_MAX_BANDS || !sfield__is_side(side, 2) || !texels || !coefs || channels < 1 ||
        channels > 3)
        return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < 6 * side * side; i++) {
        sfield__texel_basis(bands, side, i, y);
        for (c = 0; c < channels; c++)
            for (k = 0; k < n; k++) sum[c * n + k] += (double)texels[i * channels + c] * (double)y[k];
    }
    for (k = 0; k < channels * n; k++) coefs[k] = (float)sum[k];
    return SFIELD_OK;
}

/* ---- >>haar ---- */

#if SFIELD__SIMD
/* Sum and wavelets of a square by two butterflies, in the order in which they are stored, two of its squares at a time;
   from the last one on, so that a sum, which falls on the wavelet before, is written over. */
SFIELD__TARGET_AVX2 static const float *sfield__haar_level_avx2(uint32_t squares, const float *c, float *up, float *out)
{
    const __m256 odd = _mm256_castsi256_ps(_mm256_set1_epi64x(INT64_MIN)), half = _mm256_set1_ps(0.5f);
    const __m256 high = _mm256_permutevar8x32_ps(odd, _mm256_setr_epi32(0, 0, 1, 1, 0, 0, 1, 1));
    uint32_t i;
    for (i = squares; i > 0; i -= 2) {
        __m256 x = _mm256_loadu_ps(c + 4 * i - 8);
        __m128 last;
        x = _mm256_add_ps(_mm256_permute_ps(x, 0xb1), _mm256_xor_ps(x, odd));
        x = _mm256_mul_ps(half, _mm256_add_ps(_mm256_permute_ps(x, 0x4e), _mm256_xor_ps(x, high)));
        last = _mm256_extractf128_ps(x, 1);
        _mm_storeu_ps(out + squares + 3 * i - 4, last);
        _mm_storeu_ps(out + squares + 3 * i - 7, _mm256_castps256_ps128(x));
        _mm_store_ss(up + i - 1, last);
        _mm_store_ss(up + i - 2, _mm256_castps256_ps128(x));
    }
    return up;
}
#endif

/* A level's wavelets go to out, its squares' scaling coefficients to up. Morton order makes both a walk through
   memory. */
static const float *sfield__haar_level(uint32_t squares, const float *c, float *up, float *out)
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
    return up;
}

static void sfield__haar_face(uint32_t side, const float *texels, float *out, int simd)
{
    float scaling[1365], *up = scaling;
    uint32_t squares;
    (void)simd;
    for (squares = side * side / 4; squares; up += squares, squares /= 4)
#if SFIELD__SIMD
        if (simd && squares > 1) texels = sfield__haar_level_avx2(squares, texels, up, out);
        else
#endif
            texels = sfield__haar_level(squares, texels, up, out);
    out[0] = texels[0];
}

static void sfield__haar_up(const float *w, uint32_t squares, const float *scaling, float *out)
{
    uint32_t i;
    for (i = squares; i-- > 0;) {               /* from the end, so that out may be scaling */
        float s = scaling[i], x = w[3 * i], y = w[3 * i + 1], z = w[3 * i + 2], *c = out + 4 * i;
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
        for (squares = 1; squares < n; squares *= 4) sfield__haar_up(coefs + squares, squares, texels, texels);
    }
}

SFIELD_DEF sfield_result sfield_haar_forward(uint32_t side, const float *texels, float *coefs)
{
    const int simd = sfield__simd();
    uint32_t face, n = side * side;
    if (!sfield__is_side(side, 2) || !texels || !coefs || texels == coefs) return SFIELD_ERR_ARGUMENT;
    for (face = 0; face < 6; face++) sfield__haar_face(side, texels + face * n, coefs + face * n, simd);
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_haar_inverse(uint32_t side, const float *coefs, float *texels)
{
    if (!sfield__is_side(side, 2) || !texels || !coefs || texels == coefs) return SFIELD_ERR_ARGUMENT;
    sfield__haar_texels(side, coefs, texels);
    return SFIELD_OK;
}

/* Which squares have coefficients at them or below: a bit for each, level after level as the coefficients lie
   (node / 1 + 4 + 16 ...). */
#define SFIELD__MARKS 1365u                     /* (4^6 - 1) / 3 squares a face of 64 x 64 */

static uint32_t sfield__mark_base(uint32_t squares) { return (squares - 1) / 3; }

static void sfield__mark(uint32_t side, const float *coefs, uint8_t *marks)
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

/* One operand is constant below: the product is the other one, scaled. */
static void sfield__scale_tree(const sfield__trees *t, const float *from, const uint8_t *marks, float factor,
                               uint32_t squares, uint32_t i)
{
    uint32_t k;
    if (!marks[sfield__mark_base(squares) + i]) return;
    for (k = 0; k < 3; k++) t->out[squares + 3 * i + k] = factor * from[squares + 3 * i + k];
    for (k = 0; k < 4 && squares < t->leaves; k++) sfield__scale_tree(t, from, marks, factor, 4 * squares, 4 * i + k);
}

/* Returns the mean of the product over square i of a level, given the means of both; writes its wavelets. Where both
   have detail the product is that of the quarters, put together again: every tripling coefficient of Ng et al. in one
   step. Depth at most 6. */
static float sfield__multiply_tree(const sfield__trees *t, float mean_a, float mean_b, uint32_t squares, uint32_t i,
                                   float side)
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
        c[k] = squares < t->leaves ? sfield__multiply_tree(t, p, q, 4 * squares, 4 * i + k, 0.5f * side) : p * q;
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
        sfield__mark(side, t.a, marks[0]);
        sfield__mark(side, t.b, marks[1]);
        t.out[0] =
            (float)side * sfield__multiply_tree(&t, t.a[0] / (float)side, t.b[0] / (float)side, 1, 0, (float)side);
    }
}

SFIELD_DEF sfield_result sfield_haar_product(uint32_t side, const float *a, const float *b, float *out)
{
    if (!sfield__is_side(side, 2) || !a || !b || !out || out == a || out == b) return SFIELD_ERR_ARGUMENT;
    sfield__haar_multiply(side, a, b, out);
    return SFIELD_OK;
}

/* ---- >>block: what is kept and written ---- */

/* 32-bit words, little-endian in files, in the host's order in memory:

     header    SFIELD__HEADER words
     radii     shells floats, in r (SELF: none)
     SH        scale, then bias: `stride` floats a group (a shell of a frame; SELF: one), then the samples, `stride`
               bytes each: per channel n^2 bytes filled up to a multiple of 8. value = scale byte + bias
     HAAR      samples + 1 offsets into the entries, samples scales (floats), entries: `stride` words each:
               index << 16 | value, or index << 16 | r, g << 16 | b; values are signed 16 bit times the sample's scale

   Sample ((frame shells + shell) 6 + face) side^2 + y side + x of a field lies on the grid of nodes of a face, edges
   and corners included: those are stored by each face that has them, so that no query looks beyond its face. */
enum {
    SFIELD__MAGIC = 0x444c4653,     /* "SFLD" */
    SFIELD__FORMAT = 1,
    SFIELD__HEADER = 32
};

typedef struct sfield__header {     /* 32-bit fields only */
    uint32_t magic, format, bytes, crc;
    uint32_t kind, basis, logarithm, bands, cube_side, shells, position_side, spacing, frames, loop;
    uint32_t channels, samples, stride, entries;
    float    center[3], radius, inscribed, frames_per_second, window;
    uint32_t shard_begin, shard_end, reserved[5];
} sfield__header;

struct sfield_field {
    sfield__allocator allocator;
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
    float            *angle;        /* occlusion in wavelets: the solid angles of a face's texels, as wavelets */
};

static uint32_t sfield__groups(const sfield__header *h)
{
    return h->kind == SFIELD_KIND_SELF ? 1 : h->shells * h->frames;
}
static uint32_t sfield__planes(uint32_t bands) { return (bands * bands + 7) / 8 * 8; }

/* Words before the bytes of SH, or all of HAAR. */
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

/* The solid angle that a sphere of radius 1 fills at distance d > 1, over 2 pi; below, and for lights, 1 / d^2; for
   uniform shells d itself, counted down. */
SFIELD__INLINE float sfield__measure_of(float d2, uint32_t kind, uint32_t spacing)
{
    float inverse = 1 / d2, u = inverse < 1 ? inverse : 1.0f, g = u / (1 + sqrtf(1 - u));
    if (spacing == SFIELD_SPACING_UNIFORM) return -sqrtf(d2);
    return kind == SFIELD_KIND_SOURCE || d2 < 1 ? inverse : g;
}

static void sfield__bind(sfield_field *f)
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

/* Haar is orthonormal: the solid angle that a list hides is its dot product with these, the same for all six faces. */
static void sfield__find_angles(sfield_field *f)
{
    float texels[4096], direction[3];
    uint32_t i;
    for (i = 0; i < f->h.cube_side * f->h.cube_side; i++)
        texels[i] = sfield_cube_texel(f->h.cube_side, i, direction);
    sfield__haar_face(f->h.cube_side, texels, f->angle, 0);
}

/* Once the block is there, the radii of its shells in it. */
static void sfield__bind_whole(sfield_field *f)
{
    uint32_t k;
    sfield__bind(f);
    if (f->angle) sfield__find_angles(f);
    for (k = 0; k < f->h.shells; k++) {
        f->radius2[k] = f->radii[k] * f->radii[k];
        f->measure[k] = sfield__measure_of(f->radius2[k], f->h.kind, f->h.spacing);
    }
}

/* Room for the block that a header describes; the header itself is written at the end of a build. */
static sfield_result sfield__field_alloc(const sfield__allocator *a, const sfield__header *h, sfield_field **out)
{
    const int angles = h->basis == SFIELD_BASIS_HAAR && h->kind == SFIELD_KIND_OCCLUSION;
    uint64_t bytes = sfield__block_bytes(h);
    sfield_field *f;
    if (bytes > 0xffffffffu || bytes > SIZE_MAX) return SFIELD_ERR_LIMIT;
    f = (sfield_field *)sfield__alloc(a, sizeof *f + (angles ? h->cube_side * h->cube_side * sizeof *f->angle : 0));
    if (!f) return SFIELD_ERR_ALLOC;
    memset(f, 0, sizeof *f);
    f->angle = angles ? (float *)(void *)(f + 1) : NULL;
    f->allocator = *a;
    f->h = *h;
    f->h.bytes = (uint32_t)bytes;
    f->words = (uint32_t *)sfield__alloc(a, (size_t)bytes);
    if (!f->words) {
        sfield__free(a, f);
        return SFIELD_ERR_ALLOC;
    }
    sfield__bind(f);
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

static void sfield__words_out(uint8_t *to, const uint32_t *from, size_t count)
{
    size_t i;
    if (sfield__host_is_little_endian()) memcpy(to, from, 4 * count);
    else
        for (i = 0; i < count; i++) sfield__put_u32(to + 4 * i, from[i]);
}

enum { SFIELD__STEP = 1 << 18, SFIELD__STEP_SAMPLES = 1024 };      /* bytes, or samples of wavelets: milliseconds */

/* What calls that build nothing take from a desc; 0: its allocator is half. */
static int sfield__services_of(const sfield_desc *desc, sfield__allocator *a, sfield__part *part)
{
    if (desc && !sfield__allocator_valid(desc->allocator.alloc_fn, desc->allocator.free_fn)) return 0;
    *a = sfield__allocator_of(desc ? &desc->allocator : NULL);
    part->progress = desc ? desc->progress : NULL;
    part->user = desc ? desc->progress_user : NULL;
    part->from = 0;
    part->to = 1;
    return 1;
}

/* Bytes through the checksum. 0: cancelled. */
static int sfield__crc_part(uint32_t *crc, const uint8_t *bytes, size_t size, sfield__part part)
{
    size_t i, n;
    for (i = 0; i < size; i += n) {
        if (sfield__cancelled(&part, i, size, 1)) return 0;
        n = size - i < SFIELD__STEP ? size - i : (size_t)SFIELD__STEP;
        *crc = sfield__crc32(*crc, bytes + i, n);
    }
    return 1;
}

/* The file's bytes without its header through the checksum; the header comes first, from its fifth word on. */
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
        sfield__words_out(chunk, f->words + 4 + i, n);
        *crc = sfield__crc32(*crc, chunk, 4 * n);
    }
    return sfield__crc_part(crc, f->sample, sampled, sfield__part_of(part, share, 1));
}

/* Lamps of one colour have three channels that are multiples of one of them, to the bits that are kept: then that one
   is enough. 0: cancelled. */
static int sfield__find_tone(sfield_field *f, sfield__part part)
{
    const uint32_t n = f->planes, stride = f->h.stride;
    const size_t samples = f->h.shells ? f->h.samples / (f->h.shells * f->h.frames) : 0;
    uint32_t c, k, g, t = 0;
    size_t i;
    f->tone = 3;
    if (f->h.channels != 3 || f->h.basis != SFIELD_BASIS_SH || f->h.shard_end) return 1;
    for (c = 0; c < 3; c++) {
        f->ratio[c] = f->bias[c * n] + 255 * f->scale[c * n];        /* the greatest mean of the first shell */
        if (f->ratio[c] > f->ratio[t]) t = c;
    }
    if (!(f->ratio[t] > 0)) return 1;
    for (c = 0; c < 3; c++) f->ratio[c] = c == t ? f->ratio[c] : f->ratio[c] / f->ratio[t];
    f->ratio[t] = 1;
    for (g = 0; g < sfield__groups(&f->h); g++) {
        const float *scale = f->scale + (size_t)g * stride, *bias = f->bias + (size_t)g * stride;
        if (sfield__cancelled(&part, g, sfield__groups(&f->h), 1)) return 0;
        for (c = 0; c < 3; c++)
            for (k = 0; k < n && c != t; k++) {
                const float s = scale[c * n + k], b = bias[c * n + k], r = f->ratio[c], u = r * scale[t * n + k];
                const float v = r * bias[t * n + k], most = s + 1e-5f * r * fabsf(bias[t * n] + 255 * scale[t * n]);
                const uint8_t *q = f->sample + samples * g * stride + k;
                for (i = 0; i < samples; i++, q += stride)
                    if (!(fabsf(s * (float)q[c * n] + b - u * (float)q[t * n] - v) <= most)) return 1;
            }
    }
    f->tone = t;
    return 1;
}

/* 0: cancelled. */
static int sfield__seal(sfield_field *f, const sfield__part *part)
{
    sfield__part first;
    memcpy(f->words, &f->h, sizeof f->h);
    first = sfield__part_of(part, 0, 0.9f);
    if (!sfield__checksum(f, &first, &f->h.crc)) return 0;
    memcpy(f->words, &f->h, sizeof f->h);
    return sfield__find_tone(f, sfield__part_of(part, 0.9f, 1));
}

SFIELD_DEF size_t sfield_size(const sfield_field *field) { return field ? field->h.bytes : 0; }

SFIELD_DEF sfield_result sfield_write(const sfield_field *field, void *memory, size_t memory_size)
{
    if (!field || !memory) return SFIELD_ERR_ARGUMENT;
    if (memory_size < field->h.bytes) return SFIELD_ERR_MEMORY;
    sfield__words_out((uint8_t *)memory, field->words, field->word_count);
    if (field->h.basis == SFIELD_BASIS_SH)
        memcpy((uint8_t *)memory + 4 * field->word_count, field->sample, (size_t)field->h.samples * field->h.stride);
    return SFIELD_OK;
}


/* Everything in the header, so that sizes computed from it are true. */
static int sfield__header_good(const sfield__header *h)
{
    uint32_t i, self = h->kind == SFIELD_KIND_SELF, haar = h->basis == SFIELD_BASIS_HAAR;
    if (h->kind > SFIELD_KIND_SELF || h->basis < SFIELD_BASIS_SH || h->basis > SFIELD_BASIS_HAAR) return 0;
    if (h->logarithm > 1 || (h->logarithm && (h->kind != SFIELD_KIND_OCCLUSION || haar)) || h->loop > 1) return 0;
    if (haar ? h->bands != 0 : h->bands < 1 || h->bands > SFIELD_MAX_BANDS) return 0;
    if (!sfield__is_side(h->cube_side, 4) || h->channels != (h->kind == SFIELD_KIND_SOURCE ? 3u : 1u)) return 0;
    if (h->spacing < SFIELD_SPACING_GEOMETRIC || h->spacing > SFIELD_SPACING_UNIFORM) return 0;
    if (h->frames < 1 || h->frames > 256 || (h->frames > 1 && h->kind != SFIELD_KIND_SOURCE)) return 0;
    if (!sfield__in(h->frames_per_second, 1e-6f, 1e6f) || !sfield__in(h->window, 0, 1e6f)) return 0;
    for (i = 0; i < 3; i++)
        if (!sfield__in(h->center[i], -1e18f, 1e18f)) return 0;
    if (!sfield__in(h->radius, 1e-18f, 1e18f) || !sfield__in(h->inscribed, 0, h->radius)) return 0;
    for (i = 0; i < 5; i++)
        if (h->reserved[i]) return 0;
    if (h->shard_end ? self || h->shard_begin >= h->shard_end || h->shard_end > sfield__groups(h) : h->shard_begin)
        return 0;
    if (haar ? h->stride != (h->channels == 3 ? 2u : 1u) : h->stride != h->channels * sfield__planes(h->bands))
        return 0;
    if (!haar && h->entries) return 0;
    if (self) return h->shells == 0 && h->position_side == 0 && h->samples >= 1;
    if (h->shells < 2 || h->shells > 64 || h->position_side < 2 || h->position_side > 64) return 0;
    return h->samples == h->frames * h->shells * 6 * h->position_side * h->position_side;
}

static sfield_result sfield__check_content(const sfield_field *f, sfield__part part)
{
    const sfield__header *h = &f->h;
    uint32_t i, k, cells = 6 * h->cube_side * h->cube_side;
    for (i = 0; i < h->shells; i++)
        if (!sfield__in(f->radii[i], 1e-6f, 1000) || (i && f->radii[i] <= f->radii[i - 1] * 1.0001f))
            return SFIELD_ERR_FORMAT;
    if (h->basis == SFIELD_BASIS_SH) {
        for (i = 0; i < 2 * sfield__groups(h) * h->stride; i++)
            if (!sfield__in(f->scale[i], -1e24f, 1e24f)) return SFIELD_ERR_FORMAT;
        return SFIELD_OK;
    }
    if (f->offset[0] != 0 || f->offset[h->samples] != h->entries) return SFIELD_ERR_FORMAT;
    k = h->shard_end ? h->samples / sfield__groups(h) : 0;      /* shards: nothing outside, so that sfield_merge fits */
    if (k && (f->offset[h->shard_begin * k] != 0 || f->offset[h->shard_end * k] != h->entries))
        return SFIELD_ERR_FORMAT;
    for (i = 0; i < h->samples; i++) {
        if (sfield__cancelled(&part, i, h->samples, SFIELD__STEP_SAMPLES)) return SFIELD_ERR_CANCELLED;
        if (f->offset[i] > f->offset[i + 1] || f->offset[i + 1] > h->entries) return SFIELD_ERR_FORMAT;
        if (!sfield__in(f->sample_scale[i], 0, 1e24f)) return SFIELD_ERR_FORMAT;
        for (k = f->offset[i]; k < f->offset[i + 1]; k++) {
            uint32_t index = f->entry[(size_t)k * h->stride] >> 16;
            if (index >= cells || (k > f->offset[i] && index <= f->entry[(size_t)(k - 1) * h->stride] >> 16))
                return SFIELD_ERR_FORMAT;
        }
    }
    return SFIELD_OK;
}

/* The block from a file's bytes. 0: cancelled. */
static int sfield__words_in(sfield_field *f, const uint8_t *bytes, sfield__part part)
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

/* A field of a file whose header and checksum are right. */
static sfield_result sfield__take_file(sfield_field *f, const uint8_t *bytes, const sfield__part *part)
{
    sfield_result result;
    if (!sfield__words_in(f, bytes, sfield__part_of(part, 0, 0.3f))) return SFIELD_ERR_CANCELLED;
    sfield__bind_whole(f);
    result = sfield__check_content(f, sfield__part_of(part, 0.3f, 0.7f));
    if (result != SFIELD_OK) return result;
    return sfield__find_tone(f, sfield__part_of(part, 0.7f, 1)) ? SFIELD_OK : SFIELD_ERR_CANCELLED;
}

SFIELD_DEF sfield_result sfield_open(const void *data, size_t size, const sfield_desc *desc, sfield_field **out)
{
    const uint8_t *bytes = (const uint8_t *)data;
    uint32_t words[SFIELD__HEADER], i, crc = 0;
    sfield__allocator a;
    sfield__part part, rest;
    sfield__header h;
    sfield_field *f;
    sfield_result result;
    if (!data || !out) return SFIELD_ERR_ARGUMENT;
    if (!sfield__services_of(desc, &a, &part)) return SFIELD_ERR_DESC;
    if (size < sizeof h || sfield__get_u32(bytes) != SFIELD__MAGIC) return SFIELD_ERR_FORMAT;
    if (sfield__get_u32(bytes + 4) != SFIELD__FORMAT) return SFIELD_ERR_VERSION;
    for (i = 0; i < SFIELD__HEADER; i++) words[i] = sfield__get_u32(bytes + 4 * i);
    memcpy(&h, words, sizeof h);
    if (h.bytes != size || !sfield__header_good(&h) || sfield__block_bytes(&h) != size) return SFIELD_ERR_FORMAT;
    if (!sfield__crc_part(&crc, bytes + 16, size - 16, sfield__part_of(&part, 0, 0.7f))) return SFIELD_ERR_CANCELLED;
    if (crc != h.crc) return SFIELD_ERR_FORMAT;
    result = sfield__field_alloc(&a, &h, &f);
    if (result != SFIELD_OK) return result;
    rest = sfield__part_of(&part, 0.7f, 1);
    result = sfield__take_file(f, bytes, &rest);
    if (result == SFIELD_OK) *out = f;
    else sfield_free(f);
    return result;
}

SFIELD_DEF void sfield_get_info(const sfield_field *field, sfield_info *out)
{
    const sfield__header *h;
    if (!field || !out) return;
    h = &field->h;
    memset(out, 0, sizeof *out);
    out->kind = (sfield_kind)h->kind;
    out->basis = (sfield_basis)h->basis;
    out->bands = h->bands;
    out->cube_side = h->cube_side;
    out->shells = h->shells;
    out->position_side = h->position_side;
    out->frames = h->frames;
    out->spacing = (sfield_spacing)h->spacing;
    out->logarithm = (int)h->logarithm;
    out->samples = h->samples;
    out->coefficients = h->entries;
    out->bytes = h->bytes;
    memcpy(out->center, h->center, sizeof h->center);
    out->radius = h->radius;
    out->inscribed = h->inscribed;
    out->inner = h->shells ? field->radii[0] : 0;
    out->outer = h->shells ? field->radii[h->shells - 1] : 0;
    out->shard_begin = h->shard_begin;
    out->shard_end = h->shard_end;
}

/* Whether b goes on where a ends, and is made in the same way. */
static int sfield__follows(const sfield_field *a, const sfield_field *b)
{
    sfield__header x = a->h, y = b->h;
    if (x.shard_end != y.shard_begin || !y.shard_end) return 0;
    x.bytes = x.crc = x.entries = x.shard_begin = x.shard_end = 0;
    y.bytes = y.crc = y.entries = y.shard_begin = y.shard_end = 0;
    return memcmp(&x, &y, sizeof x) == 0 && memcmp(a->radii, b->radii, x.shells * sizeof *a->radii) == 0;
}

/* What a shard has built, into the whole; *entries counts the wavelets there. */
static void sfield__join(sfield_field *whole, const sfield_field *shard, uint32_t *entries)
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

/* 0: cancelled. */
static int sfield__join_all(sfield_field *whole, const sfield_field *const *shards, size_t count, sfield__part part)
{
    uint32_t used = 0;
    size_t i;
    memcpy(whole->words + SFIELD__HEADER, shards[0]->radii, whole->h.shells * sizeof *whole->radii);
    if (whole->h.basis == SFIELD_BASIS_HAAR) whole->words[SFIELD__HEADER + whole->h.shells] = 0;
    for (i = 0; i < count; i++) {
        if (sfield__cancelled(&part, i, count, 1)) return 0;
        sfield__join(whole, shards[i], &used);
    }
    sfield__bind_whole(whole);
    return 1;
}

SFIELD_DEF sfield_result sfield_merge(const sfield_field *const *shards, size_t count, const sfield_desc *desc,
                                      sfield_field **out)
{
    sfield__allocator a;
    sfield__part part, rest;
    uint64_t entries = 0;
    sfield__header h;
    sfield_field *f;
    sfield_result result;
    size_t i;
    if (!shards || !count || !out) return SFIELD_ERR_ARGUMENT;
    if (!sfield__services_of(desc, &a, &part)) return SFIELD_ERR_DESC;
    for (i = 0; i < count; i++) {
        if (!shards[i]) return SFIELD_ERR_ARGUMENT;
        if (i ? !sfield__follows(shards[i - 1], shards[i]) : shards[0]->h.shard_begin || !shards[0]->h.shard_end)
            return SFIELD_ERR_SHARD;
        entries += shards[i]->h.entries;
    }
    h = shards[0]->h;
    if (shards[count - 1]->h.shard_end != sfield__groups(&h)) return SFIELD_ERR_SHARD;
    if (entries > 0xffffffffu) return SFIELD_ERR_LIMIT;
    h.entries = (uint32_t)entries;
    h.shard_end = 0;
    result = sfield__field_alloc(&a, &h, &f);
    if (result != SFIELD_OK) return result;
    rest = sfield__part_of(&part, 0.1f, 1);
    if (!sfield__join_all(f, shards, count, sfield__part_of(&part, 0, 0.1f)) || !sfield__seal(f, &rest)) {
        sfield_free(f);
        return SFIELD_ERR_CANCELLED;
    }
    *out = f;
    return SFIELD_OK;
}

/* ---- >>views: what is seen from a sample point ---- */

enum { SFIELD__MOST_WIDTH = 512, SFIELD__EMISSIVE_WIDTH = 256, SFIELD__MOST_VIEWS = 256 };

typedef struct sfield__texels {     /* of a cube: tables */
    float *direction, *basis;       /* 3 floats; integrals of the basis, `planes` floats */
    float *angle;                   /* solid angle */
    float  node[64];                /* coordinates of the position grid */
} sfield__texels;

typedef struct sfield__view {       /* of one task */
    float    *corner;               /* x, y, z, s, t of each vertex, seen from the eye */
    uint8_t  *face;                 /* which it projects on */
    uint64_t *bits;                 /* 6 x width rows of width samples */
    float    *depth;                /* emissive meshes: 1 / distance and triangle + 1 of each sample */
    uint32_t *owner;
    int       row_low[6], row_high[6];
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
    sfield_desc       desc;
    sfield__header    h;
    void             *held[24];
    uint32_t          held_count;
    size_t            bytes, peak;
    sfield_algebra   *algebra;      /* logarithms */
    float            *position;     /* of vertices, about the center, in r */
    uint32_t         *index, *original;
    size_t            vertices, triangles;
    const float      *radiance;     /* of triangles, this frame's */
    sfield_emitter    emitter;
    const float      *points, *normals;
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
} sfield__build;

/* Sets samples x0..x1 of a row. */
static void sfield__set_bits(uint64_t *row, int x0, int x1)
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

typedef struct sfield__edges {      /* of a triangle on a face: c[0] s + c[1] t + c[2] >= 0 inside */
    float c[3][3], inverse[3];
    float det;                      /* > 0: counter-clockwise for the eye */
} sfield__edges;

/* The triangle as the cone from the eye through it: no clipping, nothing to divide by, and an edge shared by two
   triangles has the same numbers but for their sign, so that no sample falls between them. 0: seen edge on. */
static int sfield__edges_of(const float *const *corner, uint32_t face, sfield__edges *e)
{
    float q[3][3];
    int i, k;
    for (i = 0; i < 3; i++) sfield__to_face(face, corner[i], q[i]);
    for (i = 0; i < 3; i++) {
        const float *a = q[i], *b = q[(i + 1) % 3];
        e->c[i][0] = a[1] * b[2] - a[2] * b[1];
        e->c[i][1] = a[2] * b[0] - a[0] * b[2];
        e->c[i][2] = a[0] * b[1] - a[1] * b[0];
    }
    e->det = q[2][0] * e->c[0][0] + q[2][1] * e->c[0][1] + q[2][2] * e->c[0][2];
    if (!(e->det > 0 || e->det < 0)) return 0;
    for (i = 0; i < 3; i++) {
        for (k = 0; k < 3 && e->det < 0; k++) e->c[i][k] = -e->c[i][k];
        e->inverse[i] = e->c[i][0] != 0 ? 1 / e->c[i][0] : 0.0f;
    }
    return 1;
}

/* The samples of row y inside: 0 if none. box: x0, y0, x1, y1. */
static int sfield__span(const sfield__edges *e, uint32_t width, int y, const int *box, int *x0, int *x1)
{
    float half = 0.5f * (float)width, t = ((float)y + 0.5f) / half - 1, low = (float)box[0], high = (float)box[2];
    int i;
    for (i = 0; i < 3; i++) {
        float c = e->c[i][1] * t + e->c[i][2], x = (1 - c * e->inverse[i]) * half - 0.5f;
        if (e->c[i][0] > 0) low = x > low ? x : low;
        else if (e->c[i][0] < 0) high = x < high ? x : high;
        else if (c < 0) return 0;
    }
    if (!(low <= high)) return 0;
    *x0 = (int)low + ((float)(int)low < low);
    *x1 = (int)high;
    return *x0 <= *x1;
}

/* Sides that do not emit lie a little farther away: those of a sheet that shines on both would hide it by rounding. */
static void sfield__raster_face(sfield__view *v, const sfield__edges *e, uint32_t face, const int *box, uint32_t owner)
{
    int y, x, x0, x1, width = (int)v->width;
    float sum[3], half = 0.5f * (float)width, det = e->det > 0 ? e->det : -1.00001f * e->det;
    for (x = 0; x < 3; x++) sum[x] = e->c[0][x] + e->c[1][x] + e->c[2][x];
    for (y = box[1]; y <= box[3]; y++) {
        if (!sfield__span(e, v->width, y, box, &x0, &x1)) continue;
        v->row_low[face] = y < v->row_low[face] ? y : v->row_low[face];
        v->row_high[face] = y > v->row_high[face] ? y : v->row_high[face];
        if (!v->depth) {
            sfield__set_bits(v->bits + (size_t)(face * v->width + (uint32_t)y) * (v->width / 64), x0, x1);
            continue;
        }
        for (x = x0; x <= x1; x++) {
            size_t at = (size_t)(face * v->width + (uint32_t)y) * v->width + (uint32_t)x;
            float close = (sum[0] * (((float)x + 0.5f) / half - 1) + sum[1] * (((float)y + 0.5f) / half - 1) + sum[2]) /
                         det;
            if (close > v->depth[at]) {
                v->depth[at] = close;
                v->owner[at] = owner | (e->det < 0 ? 0x80000000u : 0);      /* the side that does not emit */
            }
        }
    }
}

/* Where the eye lies has the origin; faces and their coordinates of all vertices. */
static void sfield__project(const sfield__build *b, sfield__view *v, const float *eye)
{
    size_t i;
    for (i = 0; i < b->vertices; i++) {
        float *c = v->corner + 5 * i, q[3];
        uint32_t face;
        c[0] = b->position[3 * i] - eye[0];
        c[1] = b->position[3 * i + 1] - eye[1];
        c[2] = b->position[3 * i + 2] - eye[2];
        face = sfield__face_of(c);
        sfield__to_face(face, c, q);
        v->face[i] = q[2] > 0 ? (uint8_t)face : 255;
        q[2] = q[2] > 0 ? 0.5f * (float)v->width / q[2] : 0.0f;
        c[3] = q[0] * q[2] + 0.5f * (float)v->width - 0.5f;
        c[4] = q[1] * q[2] + 0.5f * (float)v->width - 0.5f;
    }
}

/* Rounds a box outwards by a little and to samples; 0: none inside. */
static int sfield__box(float x0, float y0, float x1, float y1, uint32_t width, int *box)
{
    float most = (float)width - 1;
    x0 = x0 - 0.01f > 0 ? x0 - 0.01f : 0;
    y0 = y0 - 0.01f > 0 ? y0 - 0.01f : 0;
    x1 = x1 + 0.01f < most ? x1 + 0.01f : most;
    y1 = y1 + 0.01f < most ? y1 + 0.01f : most;
    if (!(x0 <= x1 && y0 <= y1)) return 0;
    box[0] = (int)x0 + ((float)(int)x0 < x0);
    box[1] = (int)y0 + ((float)(int)y0 < y0);
    box[2] = (int)x1;
    box[3] = (int)y1;
    return box[0] <= box[2] && box[1] <= box[3];
}

static float sfield__min3(float a, float b, float c) { return a < b ? (a < c ? a : c) : b < c ? b : c; }
static float sfield__max3(float a, float b, float c) { return a > b ? (a > c ? a : c) : b > c ? b : c; }

/* A triangle over several faces: on each whose pyramid it may touch. */
static void sfield__raster_across(sfield__view *v, const float *const *corner, uint32_t owner)
{
    sfield__edges e;
    uint32_t face;
    int i;
    for (face = 0; face < 6; face++) {
        int out[5] = { 0, 0, 0, 0, 0 }, box[4];
        float x[3], y[3];
        for (i = 0; i < 3; i++) {
            float q[3];
            sfield__to_face(face, corner[i], q);
            out[0] += q[0] > q[2];
            out[1] += -q[0] > q[2];
            out[2] += q[1] > q[2];
            out[3] += -q[1] > q[2];
            out[4] += q[2] > 0;
            x[i] = q[0] / q[2];
            y[i] = q[1] / q[2];
        }
        if (out[0] == 3 || out[1] == 3 || out[2] == 3 || out[3] == 3 || out[4] == 0) continue;
        if (out[4] < 3) {
            box[0] = box[1] = 0;
            box[2] = box[3] = (int)v->width - 1;
        } else {
            float h = 0.5f * (float)v->width, o = h - 0.5f;
            if (!sfield__box(sfield__min3(x[0], x[1], x[2]) * h + o, sfield__min3(y[0], y[1], y[2]) * h + o,
                             sfield__max3(x[0], x[1], x[2]) * h + o, sfield__max3(y[0], y[1], y[2]) * h + o, v->width,
                             box))
                continue;
        }
        if (sfield__edges_of(corner, face, &e)) sfield__raster_face(v, &e, face, box, owner);
    }
}

static void sfield__raster(const sfield__build *b, sfield__view *v)
{
    size_t t;
    uint32_t face;
    for (face = 0; face < 6; face++) {
        v->row_low[face] = (int)v->width;
        v->row_high[face] = -1;
    }
    for (t = 0; t < b->triangles; t++) {
        const uint32_t *i = b->index + 3 * t;
        const float *c[3];
        uint32_t owner = v->depth ? b->original[t] + 1 : 0;
        sfield__edges e;
        int box[4];
        face = v->face[i[0]];
        c[0] = v->corner + 5 * (size_t)i[0];
        c[1] = v->corner + 5 * (size_t)i[1];
        c[2] = v->corner + 5 * (size_t)i[2];
        if (face != v->face[i[1]] || face != v->face[i[2]] || face == 255) {
            sfield__raster_across(v, c, owner);
            continue;
        }
        if (!sfield__box(sfield__min3(c[0][3], c[1][3], c[2][3]), sfield__min3(c[0][4], c[1][4], c[2][4]),
                         sfield__max3(c[0][3], c[1][3], c[2][3]), sfield__max3(c[0][4], c[1][4], c[2][4]), v->width,
                         box))
            continue;
        if (sfield__edges_of(c, face, &e)) sfield__raster_face(v, &e, face, box, owner);
    }
}

/* Samples counted into texels; the buffers are clean again afterwards. */
static void sfield__resolve(const sfield__build *b, sfield__view *v)
{
    uint32_t n = b->h.cube_side, s = v->scale, words = v->width / 64, face, x, y, k, c;
    uint64_t mask = s == 64 ? ~(uint64_t)0 : ((uint64_t)1 << s) - 1;
    for (face = 0; face < 6; face++) {
        if (v->row_high[face] < 0) continue;
        for (y = (uint32_t)v->row_low[face] / s; y <= (uint32_t)v->row_high[face] / s; y++) {
            uint64_t *row = v->bits + (size_t)(face * v->width + y * s) * words;
            for (x = 0; x < n && !v->depth; x++) {
                int count = 0;
                for (k = 0; k < s; k++)
                    count += (int)sfield__popcount(row[(size_t)k * words + x * s / 64] >> x * s % 64 & mask);
                v->texel[sfield__texel(n, face, x, y)] = (float)count / (float)(s * s);
            }
            if (!v->depth) memset(row, 0, (size_t)s * words * sizeof *row);
        }
        if (!v->depth) continue;
        for (y = (uint32_t)v->row_low[face]; y <= (uint32_t)v->row_high[face]; y++)
            for (x = 0; x < v->width; x++) {
                size_t at = (size_t)(face * v->width + y) * v->width + x;
                uint32_t owner = v->owner[at], texel = sfield__texel(n, face, x / s, y / s);
                if (!owner) continue;
                for (c = 0; c < 3; c++)
                    v->texel[c * b->cells + texel] +=
                        (owner >> 31 ? 0.0f : b->radiance[3 * (size_t)(owner - 1) + c]) / (float)(s * s);
                v->depth[at] = 0;
                v->owner[at] = 0;
            }
    }
}

/* The power of two that brings x > 0 to 1 or just above: in such units squares stay in range, and no bit changes. */
static float sfield__unit(float x)
{
    uint32_t e = sfield__to_bits(x) >> 23;
    e = e < 1u ? 1u : e > 253u ? 253u : e;
    return sfield__from_bits((254 - e) << 23);
}

/* What an analytic emitter radiates to the eye (in r, about the center) from a direction. */
static void sfield__emit(const sfield__build *b, const float *eye, const float *d, float *rgb)
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
        if (e->view) e->view(e->user, b->time, p, d, rgb);
        for (c = 0; c < 3; c++)
            if (!(sfield__finite(rgb[c]) && rgb[c] > 0)) rgb[c] = 0;
        return;
    }
    if (e->kind == SFIELD_EMITTER_SPHERE) {
        if (d2 > size * size && (along > 0 || d2 - along * along > size * size)) return;
        if ((e->normal[0] != 0 || e->normal[1] != 0 || e->normal[2] != 0) && facing < e->cosine) return;
    } else {
        const float unit = sfield__unit(r);
        float p[3], n[3], nl;
        sfield__v3 u = sfield__v3_scale(sfield__v3_load(e->u), unit), w = sfield__v3_scale(sfield__v3_load(e->v), unit);
        sfield__v3 cross = sfield__v3_cross(u, w);
        if (e->kind == SFIELD_EMITTER_RECTANGLE) sfield__v3_store(n, sfield__v3_normalize(cross));
        else memcpy(n, e->normal, sizeof n);
        nl = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
        t = -(n[0] * eye[0] + n[1] * eye[1] + n[2] * eye[2]) / (nl < 0 ? nl : -1e-30f);
        if (!(nl < 0) || !(t > 0) || !(t < 1e6f) || -nl < e->cosine) return;
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

/* Analytic lights and callbacks: samples of those texels that the bounding sphere reaches. */
static void sfield__sample(const sfield__build *b, sfield__view *v, const float *eye)
{
    uint32_t i, x, y, c, face, tx, ty, s = v->scale, n = b->h.cube_side;
    float d = sqrtf(eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2]);
    float reach = d > 1.0001f ? sqrtf(1 - 1 / (d * d)) : -1, texel = 1.5f / (float)n;
    for (i = 0; i < b->cells; i++) {
        const float *to = b->texels.direction + 3 * i;
        float sum[3] = { 0, 0, 0 }, cosine = d > 0 ? -(to[0] * eye[0] + to[1] * eye[1] + to[2] * eye[2]) / d : 1;
        /* cos(a - b) <= cos a + b: a texel's half diagonal is below 1.5 / N */
        if (cosine + texel < reach) continue;
        sfield__texel_place(n, i, &face, &tx, &ty);
        for (y = 0; y < s; y++)
            for (x = 0; x < s; x++) {
                double q[3], l;
                float dir[3], rgb[3];
                sfield__from_face(face, (2.0 * (tx * s + x) + 1) / (n * s) - 1, (2.0 * (ty * s + y) + 1) / (n * s) - 1,
                                  q);
                l = 1 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
                for (c = 0; c < 3; c++) dir[c] = (float)(q[c] * l);
                sfield__emit(b, eye, dir, rgb);
                for (c = 0; c < b->h.channels; c++) sum[c] += rgb[c];
            }
        for (c = 0; c < b->h.channels; c++) v->texel[c * b->cells + i] = sum[c] / (float)(s * s);
    }
}

/* Texels of one sample: alpha, or three channels of radiance. */
static void sfield__see(const sfield__build *b, sfield__view *v, const float *eye)
{
    float d = sqrtf(eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2]);
    uint32_t most = b->what == SFIELD__EMISSIVE ? SFIELD__EMISSIVE_WIDTH : SFIELD__MOST_WIDTH, c;
    memset(v->texel, 0, (size_t)b->h.channels * b->cells * sizeof *v->texel);
    if (most > 64 * b->h.cube_side) most = 64 * b->h.cube_side;         /* a word holds the samples of a texel's row */
    for (v->width = 64; v->width < most && ((float)v->width < 24 * d || v->width < 2 * b->h.cube_side);) v->width *= 2;
    if (b->what == SFIELD__SELF) v->width = b->h.cube_side < 32 ? 64 : 2 * b->h.cube_side;
    v->scale = v->width / b->h.cube_side;
    if (b->what == SFIELD__ANALYTIC || b->what == SFIELD__CALLBACK) {
        sfield__sample(b, v, eye);
        for (c = 0; c < b->cells && b->what == SFIELD__CALLBACK; c++) v->texel[c] = v->texel[c] < 1 ? v->texel[c] : 1;
        return;
    }
    sfield__project(b, v, eye);
    sfield__raster(b, v);
    sfield__resolve(b, v);
}

/* ---- >>build ---- */

/* Window and logarithm of a channel. */
static void sfield__finish_sh(const sfield__build *b, sfield__view *v, float *out)
{
    uint32_t k, l;
    for (l = 0, k = 0; l < b->h.bands; l++)
        for (; k < (l + 1) * (l + 1); k++) out[k] *= b->window[l];
    if (!b->h.logarithm) return;
    for (k = 0; k < b->h.bands * b->h.bands; k++) out[k] = (k ? 0 : 1 / sfield__y00) - out[k];
    sfield__sh_log(b->algebra, out, out, v->work);
}

/* texel[] against the basis into n^2 values, `planes` apart for channels. SELF: visible share times cosine. */
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
        sfield__finish_sh(b, v, out);
    }
}

/* The `rank`-th largest (0: the largest) of count values, which are put in another order. */
static float sfield__select(float *a, uint32_t count, uint32_t rank)
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

/* Weight of a wavelet for the choice: its side, that is the area times the height of a wavelet of norm 1 (Ng et al.
   2003 call their choice area-weighted). */
static float sfield__importance(const sfield__build *b, const float *haar, uint32_t i)
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

static uint32_t sfield__quantised(float x, float scale)
{
    float q = scale > 0 ? x / scale : 0;
    return (uint32_t)(int32_t)(q + (q < 0 ? -0.5f : 0.5f)) & 0xffffu;
}

static void sfield__encode_haar(const sfield__build *b, sfield__view *v, uint32_t *kept, float *scale, uint32_t *entry)
{
    uint32_t i, c, used = 0, n = 0, equal;
    float threshold = 0, most = 0, *sorted = v->key + b->cells;
    for (c = 0; c < b->h.channels; c++)
        (void)sfield_haar_forward(b->h.cube_side, v->texel + c * b->cells, v->haar + c * b->cells);
    for (i = 0; i < b->cells; i++) {
        v->key[i] = sfield__importance(b, v->haar, i);
        if (v->key[i] > 0) sorted[used++] = v->key[i];
    }
    if (used > b->most) threshold = sfield__select(sorted, used, b->most - 1);
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
        entry[0] = at << 16 | sfield__quantised(v->haar[at], *scale);
        if (b->h.channels == 3)
            entry[1] = sfield__quantised(v->haar[b->cells + at], *scale) << 16 |
                       sfield__quantised(v->haar[2 * b->cells + at], *scale);
        entry += b->h.stride;
    }
}

/* What the caller's renderer saw from sample i of the batch: coefficients, or texels to encode. */
static void sfield__encode_seen(const sfield__build *b, sfield__view *v, size_t i)
{
    float *seen = b->seen + (i - b->from) * b->seen_size, *out;
    uint32_t c, n = b->h.bands * b->h.bands;
    size_t k;
    for (k = 0; k < b->seen_size; k++) seen[k] = sfield__in(seen[k], -1e18f, 1e18f) ? seen[k] : 0;
    if (b->h.basis == SFIELD_BASIS_HAAR) {
        memcpy(v->texel, seen, b->seen_size * sizeof *seen);
        sfield__encode_haar(b, v, &b->kept[i], &b->kept_scale[i], b->entry + i * b->most * b->h.stride);
        return;
    }
    out = b->value + i * b->h.stride;
    memset(out, 0, b->h.stride * sizeof *out);
    for (c = 0; c < b->h.channels; c++, out += b->planes) {
        memcpy(out, seen + c * n, n * sizeof *out);
        sfield__finish_sh(b, v, out);
    }
}

/* Sample i of the current shell: its point in r. */
static void sfield__sample_point(const sfield__build *b, size_t i, float *eye)
{
    uint32_t side = b->h.position_side, k;
    double d[3], l;
    sfield__from_face((uint32_t)(i / ((size_t)side * side)), (double)b->texels.node[i % side],
                      (double)b->texels.node[i / side % side], d);
    l = (double)b->radius / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (k = 0; k < 3; k++) eye[k] = (float)(d[k] * l);
}

/* ---- positions inside a mesh ---- */

/* Fields are interpolated: a position inside the mesh, which sees nothing, would darken receivers between it and the
   next one outside. It takes the view from the surface instead, that of a receiver there. */

enum { SFIELD__WAYS = 27, SFIELD__CROSSINGS = 32 };
static const float sfield__outside = 1e-3f;     /* over the surface, in r; gaps below twice that are none */

typedef struct sfield__way {        /* a ray from the eye */
    float d[3];
    uint32_t face;                  /* of the cube about the eye that it goes through */
    float at[SFIELD__CROSSINGS];    /* where it meets the mesh, rising; < 0: goes in at that distance, > 0: comes out */
    int   count;                    /* of them; those beyond the last are left out */
    int   winding;                  /* times that it comes out, less times that it goes in */
} sfield__way;

/* Outwards, and to faces, edges and corners of a cube; all a little off, not to run along edges of meshes. */
static void sfield__ways(const float *eye, sfield__way *way)
{
    int i;
    for (i = 0; i < SFIELD__WAYS; i++) {
        sfield__v3 d = sfield__v3_make((float)(i % 3 - 1), (float)(i / 3 % 3 - 1), (float)(i / 9 - 1));
        if (i == SFIELD__WAYS / 2) d = sfield__v3_load(eye);
        d = sfield__v3_add(sfield__v3_normalize(d), sfield__v3_make(0.0131f, -0.0079f, 0.0107f));
        sfield__v3_store(way[i].d, sfield__v3_normalize(d));
        way[i].face = sfield__face_of(way[i].d);
        way[i].count = way[i].winding = 0;
    }
}

static void sfield__cross(sfield__way *way, float t, int out)
{
    int i = way->count < SFIELD__CROSSINGS ? way->count++ : SFIELD__CROSSINGS;
    way->winding += out ? 1 : -1;
    for (; i > 0 && fabsf(way->at[i - 1]) > t; i--)
        if (i < SFIELD__CROSSINGS) way->at[i] = way->at[i - 1];
    if (i < SFIELD__CROSSINGS) way->at[i] = out ? t : -t;
}

/* The cone test of sfield__edges_of; corners are relative to the eye. */
static void sfield__cross_all(const sfield__build *b, const sfield__view *v, sfield__way *way)
{
    size_t t;
    int i, k;
    for (t = 0; t < b->triangles; t++) {
        const uint32_t *index = b->index + 3 * t, face = v->face[index[0]];
        const int one_face = face != 255 && face == v->face[index[1]] && face == v->face[index[2]];
        sfield__v3 p[3], n[3], all;
        float det;
        for (k = 0; k < 3; k++) p[k] = sfield__v3_load(v->corner + 5 * (size_t)index[k]);
        for (k = 0; k < 3; k++) n[k] = sfield__v3_cross(p[k], p[(k + 1) % 3]);
        det = sfield__v3_dot(n[0], p[2]);
        if (!(det > 0 || det < 0)) continue;
        for (k = 0; k < 3 && det < 0; k++) n[k] = sfield__v3_scale(n[k], -1);
        all = sfield__v3_add(sfield__v3_add(n[0], n[1]), n[2]);
        for (i = 0; i < SFIELD__WAYS; i++) {
            sfield__v3 d = sfield__v3_load(way[i].d);
            if (one_face && face != way[i].face) continue;
            if (!(sfield__v3_dot(n[0], d) > 0 && sfield__v3_dot(n[1], d) > 0 && sfield__v3_dot(n[2], d) > 0)) continue;
            sfield__cross(&way[i], fabsf(det) / sfield__v3_dot(all, d), det > 0);
        }
    }
}

/* Where a ray that starts inside is out of everything: 0 if nowhere. */
static float sfield__way_out(const sfield__way *way)
{
    int i, inside = way->winding;
    for (i = 0; i < way->count && inside > 0; i++) {
        inside += way->at[i] < 0 ? 1 : -1;
        if (inside <= 0 && i + 1 < SFIELD__CROSSINGS &&
            (i + 1 == way->count || fabsf(way->at[i + 1]) > way->at[i] + 2 * sfield__outside))
            return way->at[i];
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

/* Moves the eye, where sfield__project was asked for, out of the mesh: 0 if it is not inside. Inside is where nearly
   all is hidden and most rays come out of the mesh once more than they go in, its triangles being counter-clockwise
   from outside: not behind a single sheet, not in a room, not in a cup. */
static int sfield__move_out(const sfield__build *b, const sfield__view *v, float hidden, float *eye)
{
    sfield__way way[SFIELD__WAYS];
    float nearest = 0;
    int i, k, inside = 0, best = 0;
    if (hidden < 0.99f) return 0;
    sfield__ways(eye, way);
    sfield__cross_all(b, v, way);
    for (i = 0; i < SFIELD__WAYS; i++) {
        float t = sfield__way_out(&way[i]);
        inside += way[i].winding > 0;
        if (!(t > 0 && t < 1000) || (nearest > 0 && t >= nearest)) continue;
        nearest = t;
        best = i;
    }
    if (2 * inside <= SFIELD__WAYS || !(nearest > 0)) return 0;
    for (k = 0; k < 3; k++) eye[k] += (nearest + sfield__outside) * way[best].d[k];
    return 1;
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
            const float *p = b->points + 3 * (b->first + i);
            normal = b->normals + 3 * (b->first + i);
            for (k = 0; k < 3; k++) eye[k] = (p[k] + b->offset * normal[k] - b->h.center[k]) / b->h.radius;
        } else sfield__sample_point(b, i, eye);
        sfield__see(b, v, eye);
        if ((b->what == SFIELD__MESH || b->what == SFIELD__SELF) && !b->desc.keep_inside &&
            sfield__move_out(b, v, sfield__share_hidden(b, v->texel), eye)) {
            sfield__see(b, v, eye);
            v->moved++;
        }
        if (b->h.basis == SFIELD_BASIS_SH) sfield__encode_sh(b, v, normal, b->value + i * b->h.stride);
        else
            sfield__encode_haar(b, v, &b->kept[i], &b->kept_scale[i], b->entry + i * b->most * b->h.stride);
    }
}

/* NULL and nothing else to do for the caller but to leave: all that is held is freed at the end. */
static void *sfield__hold(sfield__build *b, size_t count, size_t size)
{
    void *memory = sfield__alloc_array(&b->allocator, count ? count : 1, size);
    if (!memory) return NULL;
    SFIELD_ASSERT(b->held_count < sizeof b->held / sizeof b->held[0]);
    b->held[b->held_count++] = memory;
    b->bytes += (count ? count : 1) * size;
    b->peak = b->bytes > b->peak ? b->bytes : b->peak;
    return memory;
}

static void sfield__release(sfield__build *b)
{
    while (b->held_count) sfield__free(&b->allocator, b->held[--b->held_count]);
    sfield__free(&b->allocator, b->all);
    sfield_algebra_free(b->algebra);
    sfield_free(b->out);
}

static sfield_result sfield__read_desc(sfield__build *b, const sfield_desc *desc, sfield_kind kind)
{
    sfield_desc *d = &b->desc;
    sfield__header *h = &b->h;
    float keep, outer;
    uint32_t i, haar;
    memset(b, 0, sizeof *b);
    if (desc) *d = *desc;
    if (!sfield__allocator_valid(d->allocator.alloc_fn, d->allocator.free_fn)) return SFIELD_ERR_DESC;
    b->allocator = sfield__allocator_of(&d->allocator);
    if ((uint32_t)d->basis >= SFIELD_BASIS_COUNT || (uint32_t)d->spacing >= SFIELD_SPACING_COUNT)
        return SFIELD_ERR_DESC;
    haar = d->basis == SFIELD_BASIS_HAAR;
    h->magic = SFIELD__MAGIC;
    h->format = SFIELD__FORMAT;
    h->kind = kind;
    h->basis = haar ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH;
    h->logarithm = d->logarithm != 0;
    h->bands = haar ? 0 : d->bands ? d->bands : 4;
    h->cube_side = d->cube_side ? d->cube_side : haar ? 32 : 16;
    h->shells = kind == SFIELD_KIND_SELF ? 0 : d->shells ? d->shells : haar ? 32 : 16;
    h->position_side = kind == SFIELD_KIND_SELF ? 0 : d->position_side ? d->position_side : haar ? 32 : 16;
    h->spacing = d->spacing ? (uint32_t)d->spacing : (uint32_t)SFIELD_SPACING_GEOMETRIC;
    h->frames = d->frames ? d->frames : 1;
    h->frames_per_second = d->frames_per_second != 0 ? d->frames_per_second : 30;
    h->loop = d->loop != 0;
    h->channels = kind == SFIELD_KIND_SOURCE ? 3 : 1;
    h->window = d->window;
    h->radius = d->radius != 0 ? d->radius : 1;
    memcpy(h->center, d->center, sizeof h->center);
    b->planes = sfield__planes(h->bands);
    b->cells = 6 * h->cube_side * h->cube_side;
    h->stride = haar ? (h->channels == 3 ? 2u : 1u) : h->channels * b->planes;
    h->samples = kind == SFIELD_KIND_SELF ? 1 : h->frames * h->shells * 6 * h->position_side * h->position_side;
    h->shard_begin = d->shard_begin;
    h->shard_end = d->shard_end;
    if (d->bands > SFIELD_MAX_BANDS || !sfield__header_good(h)) return SFIELD_ERR_DESC;
    keep = d->keep != 0 ? d->keep : 0.01f;
    if (!sfield__in(keep, 0, 1)) return SFIELD_ERR_DESC;
    b->most = (uint32_t)(keep * (float)b->cells);
    b->most = b->most < 1 ? 1 : b->most;
    d->inner = d->inner != 0 ? d->inner : 0.2f;
    outer = d->outer != 0 ? d->outer : haar ? 20.0f : 8.0f;
    if (!sfield__in(d->inner, 1e-3f, 1000) || !sfield__in(outer, d->inner * 1.1f, 1000)) return SFIELD_ERR_DESC;
    for (i = 0; i < h->shells; i++) {
        float t = (float)i / (float)(h->shells - 1), ratio = outer / d->inner;
        b->radii[i] = h->spacing == SFIELD_SPACING_UNIFORM ? d->inner + t * (outer - d->inner)
                                                           : d->inner * sfield__pow(ratio, t);
        if (i && !(b->radii[i] > b->radii[i - 1] * 1.0002f)) return SFIELD_ERR_DESC;
    }
    if (h->shells) b->radii[h->shells - 1] = outer;
    sfield_sh_window(h->bands, h->window, b->window);
    return SFIELD_OK;
}

static const float *sfield__vertex(const sfield_mesh *m, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)(const void *)m->positions + i * stride);
}

/* Keeps the triangles that can be used; 0: no memory. */
static int sfield__take_triangles(sfield__build *b, const sfield_mesh *m, size_t stride, size_t count)
{
    size_t t;
    b->index = (uint32_t *)sfield__hold(b, 3 * count, sizeof *b->index);
    b->original = (uint32_t *)sfield__hold(b, count, sizeof *b->original);
    if (!b->index || !b->original) return 0;
    for (t = 0; t < count; t++) {
        uint32_t i[3], k, good = 1;
        for (k = 0; k < 3; k++) {
            i[k] = m->indices ? m->indices[3 * t + k] : (uint32_t)(3 * t + k);
            if (good) {
                sfield__v3 p = sfield__v3_load(sfield__vertex(m, stride, i[k]));
                good = sfield__v3_finite(p) && fabsf(p.x) < 1e18f && fabsf(p.y) < 1e18f && fabsf(p.z) < 1e18f;
            }
        }
        for (k = 0; k < 3 && good; k++)
            good = memcmp(sfield__vertex(m, stride, i[k]), sfield__vertex(m, stride, i[(k + 1) % 3]), 12) != 0;
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

/* Does the bounding sphere hold what is drawn, to a thousandth? Horizons, cones and the tail beyond the last shell
   trust it; fields of points have none of them. */
static int sfield__is_bounded(const sfield__build *b)
{
    size_t i;
    for (i = 0; i < 3 * b->triangles && b->h.kind != SFIELD_KIND_SELF; i++) {
        const sfield__v3 p = sfield__v3_load(b->position + 3 * (size_t)b->index[i]);
        if (sfield__v3_dot(p, p) * (0.999f * 0.999f) > 1) return 0;
    }
    return 1;
}

static sfield_result sfield__take_mesh(sfield__build *b, const sfield_mesh *m)
{
    size_t stride = m->vertex_stride ? m->vertex_stride : 12, corners = m->indices ? m->index_count : m->vertex_count,
           i, k;
    if (!m->positions || stride < 12 || stride % 4 || corners % 3 || corners / 3 > 0x7ffffffeu ||
        m->vertex_count > 0xffffffffu)
        return SFIELD_ERR_INPUT;
    if (!corners) return SFIELD_ERR_INPUT;
    for (i = 0; i < corners && m->indices; i++)
        if (m->indices[i] >= m->vertex_count) return SFIELD_ERR_INPUT;
    if (!sfield__take_triangles(b, m, stride, corners / 3)) return SFIELD_ERR_ALLOC;
    if (!b->triangles) return SFIELD_ERR_INPUT;
    if (b->desc.radius == 0) sfield__fit_sphere(b, m, stride);
    if (!sfield__in(b->h.radius, 1e-18f, 1e18f)) return SFIELD_ERR_INPUT;
    b->vertices = m->vertex_count;
    b->position = (float *)sfield__hold(b, 3 * b->vertices, sizeof *b->position);
    if (!b->position) return SFIELD_ERR_ALLOC;
    for (i = 0; i < b->vertices; i++)
        for (k = 0; k < 3; k++) {
            float x = (sfield__vertex(m, stride, i)[k] - b->h.center[k]) / b->h.radius;
            b->position[3 * i + k] = sfield__finite(x) ? x : 0;
        }
    if (!sfield__is_bounded(b)) return SFIELD_ERR_DESC;
    return SFIELD_OK;
}

/* Tables, the scratch of every task, and room for the values of a batch. */
static sfield_result sfield__prepare(sfield__build *b)
{
    const uint32_t haar = b->h.basis == SFIELD_BASIS_HAAR, planes = haar ? 0 : b->planes;
    const int mesh = b->triangles > 0, deep = b->what == SFIELD__EMISSIVE;
    size_t width = deep ? SFIELD__EMISSIVE_WIDTH : SFIELD__MOST_WIDTH, samples = 6 * width * width;
    size_t floats = b->h.channels * b->cells * (haar ? 2u : 1u) + (haar ? 2 * b->cells : 0), p;
    float *tables = (float *)sfield__hold(b, b->cells, (4 + planes) * sizeof(float)), *all, *corners;
    uint8_t *faces, *buffers;
    double *work = NULL;
    uint32_t i, k;
    b->pieces = deep ? 4u : (uint32_t)SFIELD__PIECES;
    b->view = (sfield__view *)sfield__hold(b, b->pieces, sizeof *b->view);
    all = (float *)sfield__hold(b, b->pieces, floats * sizeof *all);
    corners = (float *)sfield__hold(b, 5 * b->pieces, (mesh ? b->vertices : 1) * sizeof *corners);
    faces = (uint8_t *)sfield__hold(b, b->pieces, mesh ? b->vertices : 1);
    buffers = (uint8_t *)sfield__hold(b, b->pieces, mesh ? (deep ? 8 * samples : samples / 8) : 1);
    if (!tables || !b->view || !all || !corners || !faces || !buffers) return SFIELD_ERR_ALLOC;
    if (b->h.logarithm) {
        sfield_result result = sfield_algebra_create(b->h.bands, &b->desc.allocator, &b->algebra);
        work =
            (double *)sfield__hold(b, b->pieces, 2 * sizeof *work * b->h.bands * b->h.bands * b->h.bands * b->h.bands);
        if (result != SFIELD_OK || !work) return SFIELD_ERR_ALLOC;
    }
    memset(b->view, 0, b->pieces * sizeof *b->view);
    if (mesh) memset(buffers, 0, b->pieces * (deep ? 8 * samples : samples / 8));
    for (p = 0; p < b->pieces; p++) {
        sfield__view *v = &b->view[p];
        v->texel = all + p * floats;
        v->haar = v->texel + b->h.channels * b->cells;
        v->key = v->haar + b->h.channels * b->cells;
        v->corner = corners + 5 * p * (mesh ? b->vertices : 1);
        v->face = faces + p * (mesh ? b->vertices : 1);
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
    for (i = 0, k = b->h.position_side; i < k; i++) {          /* odd about the middle, and exact at the ends */
        float s, c, a = 2 * (float)(i < k / 2 ? i : k - 1 - i) / (float)(k - 1) - 1;
        sfield__sincos(0.785398163f * a, &s, &c);
        b->texels.node[i] = (i == 0 || i == k - 1 ? -1 : s / c) * (i < k / 2 ? 1.0f : -1.0f);
    }
    return SFIELD_OK;
}

/* 8 bits for each coefficient, scaled to its range in this shell: error at most range / 510 (T77). */
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

/* Appends the wavelets of a batch to those of all. */
static sfield_result sfield__append(sfield__build *b, size_t first)
{
    size_t i, n = 0;
    for (i = 0; i < b->count; i++) n += b->kept[i];
    if (n > 0xffffffffu - b->all_used) return SFIELD_ERR_LIMIT;
    if (!b->all || b->all_used + n > b->all_room) {         /* of nothing too: there is a pointer to add 0 to */
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

static void sfield__tasks(sfield__build *b, void (*task)(void *, size_t))
{
    size_t p;
    if (b->desc.parallel_for) b->desc.parallel_for(b->desc.parallel_user, b->pieces, task, b);
    else for (p = 0; p < b->pieces; p++) task(b, p);
}

/* The caller's renderer, for some eyes. Its not 0: the build ends. */
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

/* Which eyes are inside the mesh, by what was seen, and where they go. */
static void sfield__leave_task(void *context, size_t piece)
{
    const sfield__build *b = (const sfield__build *)context;
    sfield__view *v = &b->view[piece];
    size_t i;
    for (i = piece; i < b->to - b->from; i += b->pieces) {
        const float *seen = b->seen + i * b->seen_size;
        float hidden = b->h.basis == SFIELD_BASIS_SH ? seen[0] / 3.54490770f : sfield__share_hidden(b, seen);
        b->moved[i] = 0;
        if (!(hidden >= 0.99f)) continue;
        sfield__project(b, v, b->eyes + 3 * i);
        b->moved[i] = (uint8_t)sfield__move_out(b, v, hidden, b->eyes + 3 * i);
        v->moved += b->moved[i];
    }
}

/* Samples from .. to - 1: all, then those again that are inside the mesh, a run at a time. */
static int sfield__ask_batch(sfield__build *b)
{
    size_t i, end, count = b->to - b->from;
    for (i = 0; i < count; i++) sfield__sample_point(b, b->from + i, b->eyes + 3 * i);
    if (sfield__ask_views(b, 0, count) != 0) return 1;
    if (b->triangles == 0 || b->h.kind != SFIELD_KIND_OCCLUSION || b->desc.keep_inside) return 0;
    sfield__tasks(b, sfield__leave_task);
    for (i = 0; i < count; i = end + 1) {
        while (i < count && !b->moved[i]) i++;
        for (end = i; end < count && b->moved[end];) end++;
        if (end > i && sfield__ask_views(b, i, end) != 0) return 1;
    }
    return 0;
}

static sfield_result sfield__batch(sfield__build *b, uint32_t group)
{
    size_t step = b->what == SFIELD__VIEWS ? (size_t)SFIELD__MOST_VIEWS : b->count;
    for (b->from = 0; b->from < b->count; b->from = b->to) {
        b->to = b->count - b->from < step ? b->count : b->from + step;
        if (b->what == SFIELD__VIEWS && sfield__ask_batch(b) != 0) return SFIELD_ERR_CANCELLED;
        sfield__tasks(b, sfield__build_task);
    }
    if (b->h.basis == SFIELD_BASIS_HAAR) return sfield__append(b, b->first);
    if (b->what != SFIELD__SELF) sfield__quantise(b, b->first, group);
    return SFIELD_OK;
}

static sfield_result sfield__room(sfield__build *b, size_t batch)
{
    size_t held = b->what == SFIELD__SELF ? b->h.samples : batch;
    sfield_result result;
    if (b->what == SFIELD__VIEWS) {
        b->seen_size = b->h.channels * (b->h.bands ? b->h.bands * b->h.bands : b->cells);
        b->eyes = (float *)sfield__hold(b, SFIELD__MOST_VIEWS, 3 * sizeof *b->eyes);
        b->seen = (float *)sfield__hold(b, SFIELD__MOST_VIEWS, b->seen_size * sizeof *b->seen);
        b->moved = (uint8_t *)sfield__hold(b, SFIELD__MOST_VIEWS, 1);
        if (!b->eyes || !b->seen || !b->moved) return SFIELD_ERR_ALLOC;
    }
    if (b->h.basis == SFIELD_BASIS_SH) {
        b->value = (float *)sfield__hold(b, held, b->h.stride * sizeof *b->value);
        if (!b->value) return SFIELD_ERR_ALLOC;
        result = sfield__field_alloc(&b->allocator, &b->h, &b->out);
        if (result == SFIELD_OK && b->h.shard_end) memset(b->out->words, 0, b->out->h.bytes);
        return result;
    }
    b->kept = (uint32_t *)sfield__hold(b, batch, sizeof *b->kept);
    b->kept_scale = (float *)sfield__hold(b, batch, sizeof *b->kept_scale);
    b->entry = (uint32_t *)sfield__hold(b, batch, 4 * (size_t)b->most * b->h.stride);
    b->offsets = (uint32_t *)sfield__hold(b, (size_t)b->h.samples + 1, sizeof *b->offsets);
    b->scales = (float *)sfield__hold(b, b->h.samples, sizeof *b->scales);
    if (!b->kept || !b->kept_scale || !b->entry || !b->offsets || !b->scales) return SFIELD_ERR_ALLOC;
    memset(b->offsets, 0, ((size_t)b->h.samples + 1) * sizeof *b->offsets);
    memset(b->scales, 0, (size_t)b->h.samples * sizeof *b->scales);
    return SFIELD_OK;
}

static int sfield__goes_on(const sfield__build *b, float fraction)
{
    return !b->desc.progress || b->desc.progress(b->desc.progress_user, fraction) == 0;
}

static sfield_result sfield__all_batches(sfield__build *b)
{
    const int self = b->what == SFIELD__SELF, haar = b->h.basis == SFIELD_BASIS_HAAR;
    const float *radiance = b->radiance;
    size_t batch = self ? 2048 : 6 * (size_t)b->h.position_side * b->h.position_side;
    uint32_t groups = self ? (b->h.samples + 2047) / 2048 : sfield__groups(&b->h), g;
    const uint32_t begin = b->h.shard_begin, end = b->h.shard_end ? b->h.shard_end : groups;
    float *values;
    sfield_result result = sfield__room(b, batch);
    if (!sfield__goes_on(b, 0)) return SFIELD_ERR_CANCELLED;
    values = b->value;
    for (g = begin; g < end && result == SFIELD_OK; g++) {
        b->first = g * batch;
        b->count = self && b->h.samples - b->first < batch ? b->h.samples - b->first : batch;
        b->radius = self ? 0 : b->radii[g % b->h.shells];
        b->time = self ? 0 : (float)(g / b->h.shells) / b->h.frames_per_second;
        if (radiance) b->radiance = radiance + 3 * (size_t)(g / b->h.shells) * (b->triangles + b->skipped);
        if (self && !haar) b->value = values + b->first * b->h.stride;
        result = sfield__batch(b, g);
        if (result == SFIELD_OK && !sfield__goes_on(b, (float)(g + 1 - begin) / (float)(end - begin)))
            return SFIELD_ERR_CANCELLED;
    }
    if (result != SFIELD_OK || !self || haar) return result;
    b->value = values;                          /* one range for all points */
    b->count = b->h.samples;
    sfield__quantise(b, 0, 0);
    return SFIELD_OK;
}

/* Distance from the origin to the nearest point of a triangle. */
static float sfield__distance(const float *const *corner)
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

/* A sphere about the center that the mesh closes off: everything is hidden from there, and no triangle is nearer. */
static float sfield__inscribed(sfield__build *b)
{
    const float eye[3] = { 0, 0, 0 };
    float nearest = 1;
    size_t t;
    uint32_t i;
    sfield__see(b, &b->view[0], eye);
    for (i = 0; i < b->cells; i++)
        if (b->view[0].texel[i] < 1) return 0;
    for (t = 0; t < b->triangles; t++) {
        const float *c[3];
        float d;
        for (i = 0; i < 3; i++) c[i] = b->position + 3 * (size_t)b->index[3 * t + i];
        d = sfield__distance(c);
        nearest = d < nearest ? d : nearest;
    }
    return nearest * b->h.radius;
}

static sfield_result sfield__finish(sfield__build *b, sfield_field **out, sfield_stats *stats)
{
    double lost = 0, total = 0;
    const sfield__part silent = { NULL, NULL, 0, 1 };
    uint32_t p;
    if (b->h.basis == SFIELD_BASIS_HAAR) {
        sfield_result result;
        size_t i;
        b->h.entries = b->all_used;
        for (i = b->first + b->count; i < b->h.samples; i++) b->offsets[i + 1] = b->all_used;      /* after a shard */
        result = sfield__field_alloc(&b->allocator, &b->h, &b->out);
        if (result != SFIELD_OK) return result;
        memcpy(b->out->words + SFIELD__HEADER + b->h.shells, b->offsets, 4 * ((size_t)b->h.samples + 1));
        memcpy(b->out->words + SFIELD__HEADER + b->h.shells + b->h.samples + 1, b->scales, 4 * (size_t)b->h.samples);
        if (b->all_used)
            memcpy(b->out->words + b->out->word_count - (size_t)b->all_used * b->h.stride, b->all,
                   4 * (size_t)b->all_used * b->h.stride);
    }
    if (b->h.kind == SFIELD_KIND_OCCLUSION && b->triangles) b->out->h.inscribed = sfield__inscribed(b);
    memcpy(b->out->words + SFIELD__HEADER, b->radii, b->h.shells * sizeof *b->radii);
    sfield__bind_whole(b->out);
    sfield__seal(b->out, &silent);
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

static sfield_result sfield__run(sfield__build *b, sfield_field **out, sfield_stats *stats)
{
    sfield_result result;
    if (sfield__block_bytes(&b->h) > 0xffffffffu) return SFIELD_ERR_LIMIT;
    result = sfield__prepare(b);
    if (result == SFIELD_OK) result = sfield__all_batches(b);
    if (result == SFIELD_OK) result = sfield__finish(b, out, stats);
    return result;
}

SFIELD_DEF sfield_result sfield_build(const sfield_desc *desc, const sfield_mesh *mesh, sfield_field **out,
                                      sfield_stats *stats)
{
    sfield__build b;
    sfield_result result;
    if (!mesh || !out) return SFIELD_ERR_ARGUMENT;
    result = sfield__read_desc(&b, desc, SFIELD_KIND_OCCLUSION);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__MESH;
    result = sfield__take_mesh(&b, mesh);
    if (result == SFIELD_OK) result = sfield__run(&b, out, stats);
    sfield__release(&b);
    return result;
}

SFIELD_DEF sfield_result sfield_build_emissive(const sfield_desc *desc, const sfield_mesh *mesh, const float *radiance,
                                               sfield_field **out, sfield_stats *stats)
{
    sfield__build b;
    sfield_result result;
    size_t i, count;
    if (!mesh || !out || !radiance) return SFIELD_ERR_ARGUMENT;
    result = sfield__read_desc(&b, desc, SFIELD_KIND_SOURCE);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__EMISSIVE;
    b.radiance = radiance;
    count = (mesh->indices ? mesh->index_count : mesh->vertex_count) / 3;
    if (count > 0x7ffffffeu) return SFIELD_ERR_INPUT;
    for (i = 0; i < 3 * count * b.h.frames; i++)
        if (!sfield__in(radiance[i], 0, 1e18f)) return SFIELD_ERR_ARGUMENT;
    result = sfield__take_mesh(&b, mesh);
    if (result == SFIELD_OK) result = sfield__run(&b, out, stats);
    sfield__release(&b);
    return result;
}

/* 0: cannot be used. Fills in the radius of the bounding sphere. */
static int sfield__take_emitter(sfield__build *b)
{
    sfield_emitter *e = &b->emitter;
    const int flat = e->kind == SFIELD_EMITTER_DISC;
    float fit = e->radius, nn = 0;
    uint32_t i;
    for (i = 0; i < 3; i++) {
        if (!sfield__in(e->radiance[i], 0, 1e18f) || !sfield__in(e->normal[i], -1.1f, 1.1f)) return 0;
        nn += e->normal[i] * e->normal[i];
    }
    if (!sfield__in(e->cosine, -1, 1) || (nn > 0 || flat ? fabsf(nn - 1) > 1e-3f : 0)) return 0;
    if (e->kind == SFIELD_EMITTER_CALLBACK) return e->view != NULL && b->desc.radius > 0;
    if (e->kind == SFIELD_EMITTER_RECTANGLE) {
        sfield__v3 u = sfield__v3_load(e->u), v = sfield__v3_load(e->v);
        float x, y;
        x = sfield__v3_length(sfield__v3_add(u, v));
        y = sfield__v3_length(sfield__v3_sub(u, v));
        fit = x > y ? x : y;            /* of a side that is not finite neither: refused below */
        if (!(sfield__v3_length(sfield__v3_normalize(sfield__v3_cross(u, v))) > 0)) return 0;
    }
    if (!sfield__in(fit, 1e-17f, 1e17f)) return 0;
    if (b->desc.radius == 0) b->h.radius = fit;
    return b->h.radius >= fit * 0.999f;
}

SFIELD_DEF sfield_result sfield_build_emitter(const sfield_desc *desc, const sfield_emitter *emitter,
                                              sfield_field **out, sfield_stats *stats)
{
    sfield__build b;
    sfield_result result;
    if (!emitter || !out) return SFIELD_ERR_ARGUMENT;
    result = sfield__read_desc(&b, desc, SFIELD_KIND_SOURCE);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__ANALYTIC;
    b.emitter = *emitter;
    if ((uint32_t)b.emitter.kind >= SFIELD_EMITTER_KIND_COUNT) return SFIELD_ERR_DESC;
    if (b.emitter.kind == SFIELD_EMITTER_DEFAULT) b.emitter.kind = SFIELD_EMITTER_SPHERE;
    if (!sfield__take_emitter(&b)) return SFIELD_ERR_DESC;
    result = sfield__run(&b, out, stats);
    sfield__release(&b);
    return result;
}

SFIELD_DEF sfield_result sfield_build_callback(const sfield_desc *desc, sfield_view_fn alpha, void *user,
                                               sfield_field **out, sfield_stats *stats)
{
    sfield__build b;
    sfield_result result;
    if (!alpha || !out || !desc) return SFIELD_ERR_ARGUMENT;
    result = sfield__read_desc(&b, desc, SFIELD_KIND_OCCLUSION);
    if (result != SFIELD_OK) return result;
    if (!(desc->radius > 0)) return SFIELD_ERR_DESC;
    b.what = SFIELD__CALLBACK;
    b.emitter.kind = SFIELD_EMITTER_CALLBACK;
    b.emitter.view = alpha;
    b.emitter.user = user;
    result = sfield__run(&b, out, stats);
    sfield__release(&b);
    return result;
}

SFIELD_DEF sfield_result sfield_build_views(const sfield_desc *desc, int source, const sfield_mesh *mesh,
                                            sfield_views_fn see, void *user, sfield_field **out, sfield_stats *stats)
{
    sfield__build b;
    sfield_result result;
    if (!see || !out || (!mesh && !desc)) return SFIELD_ERR_ARGUMENT;
    result = sfield__read_desc(&b, desc, source ? SFIELD_KIND_SOURCE : SFIELD_KIND_OCCLUSION);
    if (result != SFIELD_OK) return result;
    if (!mesh && !(desc->radius > 0)) return SFIELD_ERR_DESC;
    b.what = SFIELD__VIEWS;
    b.see = see;
    b.see_user = user;
    if (mesh) result = sfield__take_mesh(&b, mesh);
    if (result == SFIELD_OK) result = sfield__run(&b, out, stats);
    sfield__release(&b);
    return result;
}

SFIELD_DEF sfield_result sfield_build_self(const sfield_desc *desc, const sfield_mesh *mesh, const float *points,
                                           const float *normals, size_t count, float offset, sfield_field **out,
                                           sfield_stats *stats)
{
    sfield__build b;
    sfield_result result;
    size_t i;
    if (!mesh || !out || !points || !normals || !count || !sfield__in(offset, 0, 1e18f)) return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < 3 * count; i++)
        if (!sfield__in(points[i], -1e18f, 1e18f) || !sfield__in(normals[i], -1.1f, 1.1f)) return SFIELD_ERR_ARGUMENT;
    if (count > 0x7fffffffu) return SFIELD_ERR_LIMIT;
    result = sfield__read_desc(&b, desc, SFIELD_KIND_SELF);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__SELF;
    b.points = points;
    b.normals = normals;
    b.offset = offset;
    b.h.samples = (uint32_t)count;
    result = sfield__take_mesh(&b, mesh);
    if (result == SFIELD_OK) result = sfield__run(&b, out, stats);
    sfield__release(&b);
    return result;
}

/* ---- >>query ---- */

typedef struct sfield__place {      /* of 16 points in a field */
    int32_t base[SFIELD__LANES];    /* sample of the inner shell, lower corner */
    int32_t shell[SFIELD__LANES];
    float   fx[SFIELD__LANES], fy[SFIELD__LANES];
    float   w0[SFIELD__LANES], w1[SFIELD__LANES];       /* of the inner and the outer shell */
} sfield__place;

/* 4/pi atan u for |u| <= 1: equal angles between the nodes of the position grid. Own fit, 6e-6, exact at the ends. */
SFIELD__INLINE float sfield__warp(float u)
{
    float z = u * u;
    return u + u * (1 - z) * (0.273219633f + z * (-0.150161507f + z * (0.0946681494f + z * (-0.0487783181f +
                                                                                          z * 0.0127531015f))));
}

/* p: x, y, z planes of 16 points about the center, in r, finite. */
static void sfield__locate_plain(const sfield_field *f, const float *p, sfield__place *out)
{
    float d2[SFIELD__LANES], u[SFIELD__LANES], v[SFIELD__LANES];
    int32_t face[SFIELD__LANES], count[SFIELD__LANES];
    int32_t side = (int32_t)f->h.position_side, shells = (int32_t)f->h.shells, k;
    float half = 0.5f * (float)(side - 1), outer2 = f->radius2[shells - 1], last = (float)(side - 2) + 0.5f;
    int l;
    for (l = 0; l < SFIELD__LANES; l++) {
        float x = p[l], y = p[16 + l], z = p[32 + l], ax = fabsf(x), ay = fabsf(y), az = fabsf(z);
        float m = ax > ay ? ax : ay, s, t, inverse;
        m = m > az ? m : az;
        inverse = 1 / (m > 1e-20f ? m : 1e-20f);
        s = m == ax ? (x > 0 ? -z : z) : m == ay ? x : z > 0 ? x : -x;
        t = m == ay && m != ax ? (y > 0 ? z : -z) : -y;
        face[l] = m == ax ? (x > 0 ? 0 : 1) : m == ay ? (y > 0 ? 2 : 3) : z > 0 ? 4 : 5;
        u[l] = s * inverse;
        v[l] = t * inverse;
        d2[l] = x * x + y * y + z * z;
        count[l] = -1;
    }
    for (k = 0; k < shells; k++)
        for (l = 0; l < SFIELD__LANES; l++) count[l] += f->radius2[k] <= d2[l] ? 1 : 0;
    for (l = 0; l < SFIELD__LANES; l++) {
        float x = (sfield__warp(u[l]) + 1) * half, y = (sfield__warp(v[l]) + 1) * half;
        int32_t xi = (int32_t)(x < last ? x : last), yi = (int32_t)(y < last ? y : last), i = count[l];
        i = i < 0 ? 0 : i;
        i = i > shells - 2 ? shells - 2 : i;
        out->fx[l] = x - (float)xi;
        out->fy[l] = y - (float)yi;
        out->shell[l] = i;
        out->base[l] = ((i * 6 + face[l]) * side + yi) * side + xi;
    }
    for (l = 0; l < SFIELD__LANES; l++) {
        float q = d2[l] > 1e-12f ? d2[l] : 1e-12f, m0 = f->measure[out->shell[l]], m1 = f->measure[out->shell[l] + 1];
        float w = (sfield__measure_of(q, f->h.kind, f->h.spacing) - m1) / (m0 - m1), tail = outer2 / q;
        w = w > 0 ? w : 0;
        w = w < 1 ? w : 1;
        out->w0[l] = w;
        out->w1[l] = (1 - w) * (tail < 1 ? tail : 1);
    }
}

/* out[k] = sum over eight samples, k < n (a multiple of 8). Weight 0 of both shells must not be asked. */
static void sfield__mix_plain(const sfield_field *f, size_t base, size_t group, const float *b, float w0, float w1,
                              uint32_t n, float *out)
{
    const size_t stride = f->h.stride, row = f->h.position_side * stride, shell = 6 * f->h.position_side * row;
    const uint8_t *q = f->sample + base * stride;
    const float *s0 = f->scale + group * stride, *b0 = f->bias + group * stride;
    uint32_t k, l;
    for (k = 0; k < n; k += 8, q += 8)
        for (l = 0; l < 8; l++) {
            float a = (float)q[l] * b[0] + (float)q[stride + l] * b[1] + (float)q[row + l] * b[2] +
                      (float)q[row + stride + l] * b[3];
            float c = (float)q[shell + l] * b[0] + (float)q[shell + stride + l] * b[1] +
                      (float)q[shell + row + l] * b[2] + (float)q[shell + row + stride + l] * b[3];
            out[k + l] = w0 * (a * s0[k + l] + b0[k + l]) + w1 * (c * s0[stride + k + l] + b0[stride + k + l]);
        }
}

#if SFIELD__SIMD
/* m ? a : b */
SFIELD__TARGET_AVX2 SFIELD__INLINE __m256 sfield__pick8(__m256 m, __m256 a, __m256 b)
{
    return _mm256_blendv_ps(b, a, m);
}

/* Eight lanes of the above, with the same roundings. */
SFIELD__TARGET_AVX2 static void sfield__locate8(const sfield_field *f, const float *p, sfield__place *out)
{
    const __m256 zero = _mm256_setzero_ps(), one = _mm256_set1_ps(1), sign = _mm256_set1_ps(-0.0f);
    const __m256 x = _mm256_loadu_ps(p), y = _mm256_loadu_ps(p + 16), z = _mm256_loadu_ps(p + 32);
    const __m256 ax = _mm256_andnot_ps(sign, x), ay = _mm256_andnot_ps(sign, y), az = _mm256_andnot_ps(sign, z);
    const __m256 m = _mm256_max_ps(_mm256_max_ps(ax, ay), az), is_x = _mm256_cmp_ps(m, ax, _CMP_EQ_OQ);
    const __m256 is_y = _mm256_andnot_ps(is_x, _mm256_cmp_ps(m, ay, _CMP_EQ_OQ));
    const __m256 up = _mm256_cmp_ps(sfield__pick8(is_x, x, sfield__pick8(is_y, y, z)), zero, _CMP_GT_OQ);
    const __m256 inverse = _mm256_div_ps(one, _mm256_max_ps(m, _mm256_set1_ps(1e-20f)));
    const __m256 half = _mm256_set1_ps(0.5f * (float)(f->h.position_side - 1));
    const __m256 cap = _mm256_set1_ps((float)f->h.position_side - 1.5f);
    const __m256 d2 = _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(x, x), _mm256_mul_ps(y, y)), _mm256_mul_ps(z, z));
    const __m256 q = _mm256_max_ps(d2, _mm256_set1_ps(1e-12f)), r = _mm256_div_ps(one, q);
    const __m256i side = _mm256_set1_epi32((int32_t)f->h.position_side);
    __m256 uv[2], m0, m1, w, tail;
    __m256i at[2], face, shell = _mm256_set1_epi32(-1);
    uint32_t k;
    uv[0] = _mm256_mul_ps(_mm256_xor_ps(sfield__pick8(is_x, z, x), _mm256_and_ps(sign, sfield__pick8(is_x, up,
                          sfield__pick8(is_y, zero, _mm256_cmp_ps(z, zero, _CMP_NGT_UQ))))), inverse);
    uv[1] = _mm256_mul_ps(_mm256_xor_ps(sfield__pick8(is_y, z, y), _mm256_andnot_ps(_mm256_and_ps(is_y, up), sign)),
                          inverse);
    face = _mm256_castps_si256(sfield__pick8(is_x, zero, sfield__pick8(is_y, _mm256_castsi256_ps(_mm256_set1_epi32(2)),
                                                                       _mm256_castsi256_ps(_mm256_set1_epi32(4)))));
    face = _mm256_add_epi32(face, _mm256_add_epi32(_mm256_set1_epi32(1), _mm256_castps_si256(up)));
    for (k = 0; k < f->h.shells; k++) {
        __m256 inside = _mm256_cmp_ps(_mm256_set1_ps(f->radius2[k]), d2, _CMP_LE_OQ);
        if (!_mm256_movemask_ps(inside)) break;
        shell = _mm256_sub_epi32(shell, _mm256_castps_si256(inside));
    }
    shell =
        _mm256_min_epi32(_mm256_max_epi32(shell, _mm256_setzero_si256()), _mm256_set1_epi32((int32_t)f->h.shells - 2));
    for (k = 0; k < 2; k++) {
        const __m256 u = uv[k], v = _mm256_mul_ps(u, u);
        __m256 s = _mm256_add_ps(_mm256_set1_ps(-0.0487783181f), _mm256_mul_ps(v, _mm256_set1_ps(0.0127531015f)));
        s = _mm256_add_ps(_mm256_set1_ps(0.0946681494f), _mm256_mul_ps(v, s));
        s = _mm256_add_ps(_mm256_set1_ps(-0.150161507f), _mm256_mul_ps(v, s));
        s = _mm256_add_ps(_mm256_set1_ps(0.273219633f), _mm256_mul_ps(v, s));
        s = _mm256_add_ps(u, _mm256_mul_ps(_mm256_mul_ps(u, _mm256_sub_ps(one, v)), s));
        s = _mm256_mul_ps(_mm256_add_ps(s, one), half);
        at[k] = _mm256_cvttps_epi32(_mm256_min_ps(s, cap));
        _mm256_storeu_ps(k ? out->fy : out->fx, _mm256_sub_ps(s, _mm256_cvtepi32_ps(at[k])));
    }
    face = _mm256_add_epi32(_mm256_mullo_epi32(shell, _mm256_set1_epi32(6)), face);
    face = _mm256_add_epi32(_mm256_mullo_epi32(_mm256_add_epi32(_mm256_mullo_epi32(face, side), at[1]), side), at[0]);
    _mm256_storeu_si256((__m256i *)(void *)out->base, face);
    _mm256_storeu_si256((__m256i *)(void *)out->shell, shell);
    m0 = _mm256_i32gather_ps(f->measure, shell, 4);
    m1 = _mm256_i32gather_ps(f->measure + 1, shell, 4);
    if (f->h.spacing == SFIELD_SPACING_UNIFORM) w = _mm256_xor_ps(sign, _mm256_sqrt_ps(q));
    else if (f->h.kind == SFIELD_KIND_SOURCE) w = r;
    else {
        const __m256 u = _mm256_min_ps(r, one);
        w = _mm256_div_ps(u, _mm256_add_ps(one, _mm256_sqrt_ps(_mm256_sub_ps(one, u))));
        w = sfield__pick8(_mm256_cmp_ps(q, one, _CMP_LT_OQ), r, w);
    }
    w = _mm256_div_ps(_mm256_sub_ps(w, m1), _mm256_sub_ps(m0, m1));
    w = _mm256_min_ps(_mm256_max_ps(w, zero), one);
    tail = _mm256_div_ps(_mm256_set1_ps(f->radius2[f->h.shells - 1]), q);
    _mm256_storeu_ps(out->w0, w);
    _mm256_storeu_ps(out->w1, _mm256_mul_ps(_mm256_sub_ps(one, w), _mm256_min_ps(tail, one)));
}

SFIELD__TARGET_AVX2 static void sfield__locate_avx2(const sfield_field *f, const float *p, sfield__place *out)
{
    sfield__place high;
    sfield__locate8(f, p, out);
    sfield__locate8(f, p + 8, &high);
    memcpy(out->base + 8, high.base, 32);
    memcpy(out->shell + 8, high.shell, 32);
    memcpy(out->fx + 8, high.fx, 32);
    memcpy(out->fy + 8, high.fy, 32);
    memcpy(out->w0 + 8, high.w0, 32);
    memcpy(out->w1 + 8, high.w1, 32);
}

SFIELD__TARGET_AVX2 SFIELD__INLINE __m256 sfield__bytes8(const uint8_t *q)
{
    return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)(const void *)q)));
}

SFIELD__TARGET_AVX2 static void sfield__mix_avx2(const sfield_field *f, size_t base, size_t group, const float *b,
                                                 float w0, float w1, uint32_t n, float *out)
{
    const size_t stride = f->h.stride, row = f->h.position_side * stride, shell = 6 * f->h.position_side * row;
    const uint8_t *q = f->sample + base * stride;
    const float *s0 = f->scale + group * stride, *b0 = f->bias + group * stride;
    const __m256 x0 = _mm256_set1_ps(b[0]), x1 = _mm256_set1_ps(b[1]), x2 = _mm256_set1_ps(b[2]),
                 x3 = _mm256_set1_ps(b[3]);
    uint32_t k;
    for (k = 0; k < n; k += 8, q += 8) {
        __m256 a = _mm256_mul_ps(sfield__bytes8(q), x0), c = _mm256_mul_ps(sfield__bytes8(q + shell), x0);
        a = _mm256_fmadd_ps(sfield__bytes8(q + stride), x1, a);
        c = _mm256_fmadd_ps(sfield__bytes8(q + shell + stride), x1, c);
        a = _mm256_fmadd_ps(sfield__bytes8(q + row), x2, a);
        c = _mm256_fmadd_ps(sfield__bytes8(q + shell + row), x2, c);
        a = _mm256_fmadd_ps(sfield__bytes8(q + row + stride), x3, a);
        c = _mm256_fmadd_ps(sfield__bytes8(q + shell + row + stride), x3, c);
        a = _mm256_fmadd_ps(a, _mm256_loadu_ps(s0 + k), _mm256_loadu_ps(b0 + k));
        c = _mm256_fmadd_ps(c, _mm256_loadu_ps(s0 + stride + k), _mm256_loadu_ps(b0 + stride + k));
        a = _mm256_mul_ps(a, _mm256_set1_ps(w0));
        _mm256_storeu_ps(out + k, _mm256_fmadd_ps(c, _mm256_set1_ps(w1), a));
    }
}

SFIELD__TARGET_AVX2 static void sfield__turn8_avx2(const float *in, size_t in_stride, float *out, size_t out_stride)
{
    __m256 r[8], t[8];
    size_t i;
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
}

/* A source's channels of n coefficients as mix would make them, each with its dot product with t: rgb += them. */
SFIELD__TARGET_AVX2 static void sfield__mix_dot_avx2(const sfield_field *f, size_t base, size_t group, const float *b,
                                                     float w0, float w1, const float *t, uint32_t n, float *rgb)
{
    const uint32_t begin = f->tone < 3 ? f->tone : 0, end = f->tone < 3 ? f->tone + 1 : 3;
    const size_t stride = f->h.stride, row = f->h.position_side * stride, shell = 6 * f->h.position_side * row;
    const uint8_t *q = f->sample + base * stride + begin * n;
    const float *s0 = f->scale + group * stride + begin * n, *b0 = f->bias + group * stride + begin * n;
    const __m256 x0 = _mm256_set1_ps(b[0]), x1 = _mm256_set1_ps(b[1]), x2 = _mm256_set1_ps(b[2]),
                 x3 = _mm256_set1_ps(b[3]);
    uint32_t k, c;
    for (c = begin; c < end; c++) {
        __m256 sum = _mm256_setzero_ps(), a, e;
        __m128 four;
        for (k = 0; k < n; k += 8, q += 8, s0 += 8, b0 += 8) {
            a = _mm256_mul_ps(sfield__bytes8(q), x0), e = _mm256_mul_ps(sfield__bytes8(q + shell), x0);
            a = _mm256_fmadd_ps(sfield__bytes8(q + stride), x1, a);
            e = _mm256_fmadd_ps(sfield__bytes8(q + shell + stride), x1, e);
            a = _mm256_fmadd_ps(sfield__bytes8(q + row), x2, a);
            e = _mm256_fmadd_ps(sfield__bytes8(q + shell + row), x2, e);
            a = _mm256_fmadd_ps(sfield__bytes8(q + row + stride), x3, a);
            e = _mm256_fmadd_ps(sfield__bytes8(q + shell + row + stride), x3, e);
            a = _mm256_fmadd_ps(a, _mm256_loadu_ps(s0), _mm256_loadu_ps(b0));
            e = _mm256_fmadd_ps(e, _mm256_loadu_ps(s0 + stride), _mm256_loadu_ps(b0 + stride));
            a = _mm256_fmadd_ps(e, _mm256_set1_ps(w1), _mm256_mul_ps(a, _mm256_set1_ps(w0)));
            sum = _mm256_fmadd_ps(a, _mm256_loadu_ps(t + k), sum);
        }
        four = _mm_add_ps(_mm256_castps256_ps128(sum), _mm256_extractf128_ps(sum, 1));
        four = _mm_add_ps(four, _mm_movehl_ps(four, four));
        rgb[c] += _mm_cvtss_f32(_mm_add_ss(four, _mm_movehdup_ps(four)));
    }
}

SFIELD__TARGET_AVX2 static void sfield__recall_avx2(const int16_t *value, const float *scale, uint32_t n, float *t)
{
    uint32_t k;
    for (k = 0; k < n; k += 8) {
        __m128i v = _mm_loadu_si128((const __m128i *)(const void *)(value + k));
        _mm256_storeu_ps(t + k,
                         _mm256_mul_ps(_mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(v)), _mm256_loadu_ps(scale + (k & 8))));
    }
}

SFIELD__TARGET_AVX512 static void sfield__recall_avx512(const int16_t *value, const float *scale, uint32_t n, float *t)
{
    const __m512 by = _mm512_loadu_ps(scale);
    const __mmask16 all = (__mmask16)0xffff;    /* gcc 12's conversions without a mask warn of themselves */
    uint32_t k;
    for (k = 0; k < n; k += 16) {
        __m256i v = _mm256_loadu_si256((const __m256i *)(const void *)(value + k));
        __m512 x = _mm512_maskz_cvtepi32_ps(all, _mm512_maskz_cvtepi16_epi32(all, v));
        _mm512_storeu_ps(t + k, _mm512_mul_ps(x, by));
    }
}
#endif

static void sfield__locate16(const sfield_field *f, const float *p, sfield__place *out, int simd)
{
#if SFIELD__SIMD
    if (simd) {
        sfield__locate_avx2(f, p, out);
        return;
    }
#endif
    (void)simd;
    sfield__locate_plain(f, p, out);
}

static void sfield__mix(const sfield_field *f, size_t base, size_t group, const float *b, float w0, float w1,
                        uint32_t n, float *out, int simd)
{
#if SFIELD__SIMD
    if (simd) {
        sfield__mix_avx2(f, base, group, b, w0, w1, n, out);
        return;
    }
#endif
    (void)simd;
    sfield__mix_plain(f, base, group, b, w0, w1, n, out);
}

/* 16 vectors of n floats (a multiple of 8) to n planes of 16. */
static void sfield__turn(const float *in, uint32_t n, float *out, int simd)
{
    uint32_t k, l;
#if SFIELD__SIMD
    if (simd) {
        for (k = 0; k < n; k += 8)
            for (l = 0; l < SFIELD__LANES; l += 8)
                sfield__turn8_avx2(in + k + l * n, n, out + k * SFIELD__LANES + l, SFIELD__LANES);
        return;
    }
#endif
    (void)simd;
    for (k = 0; k < n; k++)
        for (l = 0; l < SFIELD__LANES; l++) out[k * SFIELD__LANES + l] = in[l * n + k];
}

/* Neighbours mostly lie between the same eight samples. Those are made floats once, and go on all lanes, by weights of
   0 where they do not belong: each value gets the roundings that its lane by itself gets of mix. */
typedef struct sfield__eight {
    uint32_t     n;                             /* coefficients, a multiple of 8 */
    const float *s0, *b0, *s1, *b1;             /* scale and bias of both shells */
    float        q[8 * SFIELD_MAX_COEFS];       /* of eight samples, corners of the inner shell first */
} sfield__eight;

#define SFIELD__SHELL(V, q, s, b)                                                                                      \
    sfield__##V##_fma(sfield__##V##_fma(sfield__##V##_set1((q)[3 * n]), x3,                                            \
                      sfield__##V##_fma(sfield__##V##_set1((q)[2 * n]), x2,                                            \
                      sfield__##V##_fma(sfield__##V##_set1((q)[n]), x1,                                                \
                      sfield__##V##_mul(sfield__##V##_set1((q)[0]), x0)))),                                            \
                      sfield__##V##_set1(*(s)), sfield__##V##_set1(*(b)))
#define SFIELD__CORNERS(V)                                                                                             \
    const sfield__##V one = sfield__##V##_set1(1), fx = sfield__##V##_load(at->fx), fy = sfield__##V##_load(at->fy);   \
    const sfield__##V gx = sfield__##V##_sub(one, fx), gy = sfield__##V##_sub(one, fy);                                \
    const sfield__##V x0 = sfield__##V##_mul(gx, gy), x1 = sfield__##V##_mul(fx, gy), x2 = sfield__##V##_mul(gx, fy),  \
                      x3 = sfield__##V##_mul(fx, fy), own = sfield__##V##_load(factor),                                \
                      w0 = sfield__##V##_mul(sfield__##V##_load(at->w0), own),                                         \
                      w1 = sfield__##V##_mul(sfield__##V##_load(at->w1), own);                                         \
    const float *q = c->q, *s0 = c->s0, *b0 = c->b0, *s1 = c->s1, *b1 = c->b1;                                         \
    const uint32_t n = c->n;

/* out: n planes, +=  where there is more; sum: += what every lane has of t. */
#define SFIELD__EIGHTS(V, TARGET)                                                                                      \
    TARGET static void sfield__eight_mix_##V(const sfield__eight *c, const sfield__place *at, const float *factor,     \
                                             int more, float *out)                                                     \
    {                                                                                                                  \
        SFIELD__CORNERS(V)                                                                                             \
        uint32_t k;                                                                                                    \
        for (k = 0; k < n; k++, out += 16) {                                                                           \
            sfield__##V a = sfield__##V##_mul(SFIELD__SHELL(V, q + k, s0 + k, b0 + k), w0);                            \
            a = sfield__##V##_fma(SFIELD__SHELL(V, q + 4 * n + k, s1 + k, b1 + k), w1, a);                             \
            if (more) a = sfield__##V##_fma(sfield__##V##_load(out), one, a);                                          \
            sfield__##V##_store(out, a);                                                                               \
        }                                                                                                              \
    }                                                                                                                  \
    TARGET static void sfield__eight_dot_##V(const sfield__eight *c, const sfield__place *at, const float *factor,     \
                                             const float *t, float *sum)                                               \
    {                                                                                                                  \
        SFIELD__CORNERS(V)                                                                                             \
        sfield__##V part[8];                                                                                           \
        uint32_t k, i;                                                                                                 \
        for (k = 0; k < n; k++) {                                                                                      \
            sfield__##V a = sfield__##V##_mul(SFIELD__SHELL(V, q + k, s0 + k, b0 + k), w0);                            \
            a = sfield__##V##_fma(SFIELD__SHELL(V, q + 4 * n + k, s1 + k, b1 + k), w1, a);                             \
            part[k & 7] = k < 8 ? sfield__##V##_mul(a, sfield__##V##_load(t + 16 * k))                                 \
                                : sfield__##V##_fma(a, sfield__##V##_load(t + 16 * k), part[k & 7]);                   \
        }                                                                                                              \
        for (k = 4; k > 0; k /= 2)                                                                                     \
            for (i = 0; i < k; i++) part[i] = sfield__##V##_fma(part[i], one, part[i + k]);                            \
        sfield__##V##_store(sum, sfield__##V##_fma(part[0], one, sfield__##V##_load(sum)));                            \
    }

SFIELD__EIGHTS(plain, )
#if SFIELD__SIMD
SFIELD__EIGHTS(avx2, SFIELD__TARGET_AVX2)
SFIELD__EIGHTS(avx512, SFIELD__TARGET_AVX512)

/* All bits of the lanes of a mask, from lane l on. */
SFIELD__TARGET_AVX2 SFIELD__INLINE __m256 sfield__lanes8(uint32_t mask, uint32_t l)
{
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32((int32_t)(mask >> l)), bit), bit));
}

SFIELD__TARGET_AVX2 static uint32_t sfield__same_eight_avx2(const int32_t *base, int32_t wanted)
{
    const __m256i w = _mm256_set1_epi32(wanted);
    __m256i low = _mm256_cmpeq_epi32(_mm256_loadu_si256((const __m256i *)(const void *)base), w);
    __m256i high = _mm256_cmpeq_epi32(_mm256_loadu_si256((const __m256i *)(const void *)(base + 8)), w);
    return (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(low)) |
           (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(high)) << 8;
}

SFIELD__TARGET_AVX2 static void sfield__eight_bytes_avx2(const uint8_t *sample, size_t stride, size_t row, size_t shell,
                                                         uint32_t n, float *q)
{
    uint32_t k;
    for (k = 0; k < n; k += 8, sample += 8, q += 8) {
        _mm256_storeu_ps(q, sfield__bytes8(sample));
        _mm256_storeu_ps(q + n, sfield__bytes8(sample + stride));
        _mm256_storeu_ps(q + 2 * n, sfield__bytes8(sample + row));
        _mm256_storeu_ps(q + 3 * n, sfield__bytes8(sample + row + stride));
        _mm256_storeu_ps(q + 4 * n, sfield__bytes8(sample + shell));
        _mm256_storeu_ps(q + 5 * n, sfield__bytes8(sample + shell + stride));
        _mm256_storeu_ps(q + 6 * n, sfield__bytes8(sample + shell + row));
        _mm256_storeu_ps(q + 7 * n, sfield__bytes8(sample + shell + row + stride));
    }
}
#endif
#undef SFIELD__EIGHTS

/* Lanes by the eight samples that they lie between: how many such groups, or 0 where lane by lane costs less. */
static uint32_t sfield__eights(const sfield__place *at, uint32_t lanes, uint32_t *group, int simd)
{
    const uint32_t most = sfield__popcount(lanes) / SFIELD__SHARED;
    uint32_t count = 0, l;
    for (; lanes && count < most; lanes &= ~group[count++]) {
        uint32_t first = 0, same = 0;
        while (!(lanes >> first & 1)) first++;
#if SFIELD__SIMD
        if (simd) same = sfield__same_eight_avx2(at->base, at->base[first]);
        else
#endif
            for (l = 0; l < SFIELD__LANES; l++) same |= (uint32_t)(at->base[l] == at->base[first]) << l;
        group[count] = same & lanes;
    }
    (void)simd;
    return lanes ? 0 : count;
}

/* The eight samples about lane l in the frame whose first sample and group are given: n coefficients from one on. */
static void sfield__eight_load(const sfield_field *f, size_t base, size_t group, uint32_t from, uint32_t n,
                               sfield__eight *c, int simd)
{
    const size_t stride = f->h.stride, row = f->h.position_side * stride, shell = 6 * f->h.position_side * row;
    const uint8_t *q = f->sample + base * stride + from;
    uint32_t i, k;
    c->n = n;
    c->s0 = f->scale + group * stride + from;
    c->b0 = f->bias + group * stride + from;
    c->s1 = c->s0 + stride;
    c->b1 = c->b0 + stride;
#if SFIELD__SIMD
    if (simd) {
        sfield__eight_bytes_avx2(q, stride, row, shell, n, c->q);
        return;
    }
#endif
    (void)simd;
    for (i = 0; i < 8; i++)
        for (k = 0; k < n; k++)
            c->q[i * n + k] = (float)q[(i & 1) * stride + (i >> 1 & 1) * row + (i >> 2) * shell + k];
}

static void sfield__eight_mix(const sfield__eight *c, const sfield__place *at, const float *factor, int more,
                              float *out, int simd)
{
#if SFIELD__SIMD
    if (simd) {
        (simd == 2 ? sfield__eight_mix_avx512 : sfield__eight_mix_avx2)(c, at, factor, more, out);
        return;
    }
#endif
    (void)simd;
    sfield__eight_mix_plain(c, at, factor, more, out);
}

static void sfield__eight_dot(const sfield__eight *c, const sfield__place *at, const float *factor, const float *t,
                              float *sum, int simd)
{
#if SFIELD__SIMD
    if (simd) {
        (simd == 2 ? sfield__eight_dot_avx512 : sfield__eight_dot_avx2)(c, at, factor, t, sum);
        return;
    }
#endif
    (void)simd;
    sfield__eight_dot_plain(c, at, factor, t, sum);
}

#if SFIELD__SIMD
SFIELD__TARGET_AVX2 static void sfield__select_avx2(const float *in, uint32_t n, uint32_t mask, float *out)
{
    const __m256 low = sfield__lanes8(mask, 0), high = sfield__lanes8(mask, 8);
    uint32_t k;
    for (k = 0; k < n; k += SFIELD__LANES) {
        _mm256_storeu_ps(out + k, _mm256_and_ps(low, _mm256_loadu_ps(in + k)));
        _mm256_storeu_ps(out + k + 8, _mm256_and_ps(high, _mm256_loadu_ps(in + k + 8)));
    }
}
#endif

/* Zero where a mask has no bit. */
static void sfield__select16(const float *in, uint32_t n, uint32_t mask, float *out, int simd)
{
    uint32_t k, l;
#if SFIELD__SIMD
    if (simd) {
        sfield__select_avx2(in, n, mask, out);
        return;
    }
#endif
    (void)simd;
    for (k = 0; k < n; k += SFIELD__LANES)
        for (l = 0; l < SFIELD__LANES; l++) out[k + l] = mask >> l & 1 ? in[k + l] : 0.0f;
}

static void sfield__corners(const sfield__place *at, int l, float *b)
{
    float x = at->fx[l], y = at->fy[l];
    b[0] = (1 - x) * (1 - y);
    b[1] = x * (1 - y);
    b[2] = (1 - x) * y;
    b[3] = x * y;
}

/* Frames before and after a time, and how far it is on the way. Loops have no beginning either. */
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

/* Lane l of a place, harmonics: n floats (of each channel in turn). */
static void sfield__fetch(const sfield_field *f, const sfield__place *at, int l, float time, uint32_t n, float *out,
                          int simd)
{
    size_t samples = 6 * (size_t)f->h.position_side * f->h.position_side * f->h.shells;
    uint32_t before, after, k;
    float b[4], t = sfield__frames_at(f, time, &before, &after), next[3 * SFIELD_MAX_COEFS];
    sfield__corners(at, l, b);
    sfield__mix(f, before * samples + (size_t)at->base[l], before * f->h.shells + (size_t)at->shell[l], b,
                at->w0[l] * (1 - t), at->w1[l] * (1 - t), n, out, simd);
    if (t <= 0) return;
    sfield__mix(f, after * samples + (size_t)at->base[l], after * f->h.shells + (size_t)at->shell[l], b, at->w0[l] * t,
                at->w1[l] * t, n, next, simd);
    for (k = 0; k < n; k++) out[k] += next[k];
}

/* The lists of wavelets around a point: which samples with which weights. */
typedef struct sfield__lists { size_t sample[16]; float weight[16]; uint32_t count; } sfield__lists;

static void sfield__find_lists(const sfield_field *f, const sfield__place *at, int l, float time, sfield__lists *out)
{
    size_t side = f->h.position_side, shell = 6 * side * side;
    uint32_t frame[2], i, j, k;
    float b[4], t = sfield__frames_at(f, time, &frame[0], &frame[1]);
    sfield__corners(at, l, b);
    out->count = 0;
    for (k = 0; k < 2; k++)
        for (j = 0; j < 2; j++)
            for (i = 0; i < 4; i++) {
                float w = b[i] * (j ? at->w1[l] : at->w0[l]) * (k ? t : 1 - t);
                if (!(w > 0)) continue;
                out->weight[out->count] = w;
                out->sample[out->count++] = frame[k] * f->h.shells * shell + (size_t)at->base[l] + j * shell + (i & 1) +
                                            (i >> 1) * side;
            }
}

static float sfield__half(uint32_t bits) { return (float)(int32_t)((bits & 0xffffu) ^ 0x8000u) - 32768.0f; }

/* coefs += weight x what sample holds, all channels, planes `cells` apart. */
static void sfield__scatter(const sfield_field *f, size_t sample, float weight, float *coefs)
{
    const uint32_t *e = f->entry + (size_t)f->offset[sample] * f->h.stride, cells = 6 * f->h.cube_side * f->h.cube_side;
    const uint32_t *end = f->entry + (size_t)f->offset[sample + 1] * f->h.stride;
    weight *= f->sample_scale[sample];
    for (; e < end; e += f->h.stride) {
        coefs[e[0] >> 16] += weight * sfield__half(e[0]);
        if (f->h.stride == 1) continue;
        coefs[cells + (e[0] >> 16)] += weight * sfield__half(e[1] >> 16);
        coefs[2 * cells + (e[0] >> 16)] += weight * sfield__half(e[1]);
    }
}

static void sfield__query_sh(const sfield_field *f, const sfield__place *at, int l, float time, float *out)
{
    float v[3 * SFIELD_MAX_COEFS];
    uint32_t k, c, n = f->h.bands * f->h.bands;
    sfield__fetch(f, at, l, time, f->h.stride, v, 0);
    for (c = 0; c < f->h.channels; c++)
        for (k = 0; k < n; k++) {
            float x = v[c * f->planes + k];
            out[c * n + k] = f->h.kind == SFIELD_KIND_SOURCE || f->h.logarithm ? x : (k ? 0 : 1 / sfield__y00) - x;
        }
}

static void sfield__query_haar(const sfield_field *f, const sfield__place *at, int l, float time, float *out)
{
    uint32_t cells = 6 * f->h.cube_side * f->h.cube_side, face, i, c;
    float coefs[4096];
    sfield__lists lists;
    sfield__find_lists(f, at, l, time, &lists);
    memset(out, 0, (size_t)f->h.channels * cells * sizeof *out);
    for (i = 0; i < lists.count; i++) sfield__scatter(f, lists.sample[i], lists.weight[i], out);
    for (c = 0; c < f->h.channels; c++)
        for (face = 0; face < 6; face++) {
            uint32_t n = cells / 6, squares;
            float *t = out + c * cells + face * n;
            memcpy(coefs, t, n * sizeof *t);
            for (squares = 1; squares < n; squares *= 4) sfield__haar_up(coefs + squares, squares, t, t);
            for (i = 0; i < n && f->h.kind != SFIELD_KIND_SOURCE; i++) t[i] = 1 - t[i];
        }
}

/* 16 positions in a field's space as planes about its center, in r; not finite ones at the center with no weight. */
static uint32_t sfield__gather(const sfield_field *f, const float *positions, size_t count, float *p)
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

SFIELD_DEF sfield_result sfield_query(const sfield_field *f, size_t count, const float *positions, float time,
                                      float *out)
{
    float p[3 * SFIELD__LANES];
    sfield__place at;
    size_t i, size;
    uint32_t l, good, haar, n;
    if (!f || !positions || !out) return SFIELD_ERR_ARGUMENT;
    if (f->h.kind == SFIELD_KIND_SELF) return SFIELD_ERR_BASIS;
    if (f->h.shard_end) return SFIELD_ERR_SHARD;
    haar = f->h.basis == SFIELD_BASIS_HAAR;
    size = (size_t)f->h.channels * (haar ? 6 * f->h.cube_side * f->h.cube_side : f->h.bands * f->h.bands);
    for (i = 0; i < count; i += SFIELD__LANES) {
        n = count - i < SFIELD__LANES ? (uint32_t)(count - i) : (uint32_t)SFIELD__LANES;
        good = sfield__gather(f, positions + 3 * i, n, p);
        sfield__locate16(f, p, &at, 0);
        for (l = 0; l < n; l++) {
            float *o = out + (i + l) * size;
            size_t k;
            if (!(good >> l & 1)) {
                for (k = 0; k < size; k++) o[k] = haar && f->h.kind != SFIELD_KIND_SOURCE ? 1.0f : 0.0f;
                if (!haar && f->h.kind != SFIELD_KIND_SOURCE && !f->h.logarithm) o[0] = 1 / sfield__y00;
            } else if (haar) sfield__query_haar(f, &at, (int)l, time, o);
            else sfield__query_sh(f, &at, (int)l, time, o);
        }
    }
    return SFIELD_OK;
}

/* Share of the sphere of directions that an occlusion field of wavelets hides at lane l. */
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
            own += sfield__half(f->entry[k]) * f->angle[f->entry[k] >> 16 & in_face];
        sum += lists.weight[i] * f->sample_scale[sample] * own;
    }
    return sum * 0.0795774715f;                 /* of 4 pi */
}

SFIELD_DEF sfield_result sfield_ambient(const sfield_field *f, size_t count, const float *positions, float *out)
{
    float p[3 * SFIELD__LANES], first[8];
    sfield__place at;
    uint32_t l, n, good;
    size_t i;
    if (!f || !positions || !out) return SFIELD_ERR_ARGUMENT;
    if (f->h.kind != SFIELD_KIND_OCCLUSION || f->h.logarithm) return SFIELD_ERR_BASIS;
    if (f->h.shard_end) return SFIELD_ERR_SHARD;
    for (i = 0; i < count; i += n) {
        n = count - i < SFIELD__LANES ? (uint32_t)(count - i) : (uint32_t)SFIELD__LANES;
        good = sfield__gather(f, positions + 3 * i, n, p);
        sfield__locate16(f, p, &at, 0);
        for (l = 0; l < n; l++) {
            float hidden = 0;
            if (f->h.basis == SFIELD_BASIS_SH) {
                sfield__fetch(f, &at, (int)l, 0, 8, first, 0);
                hidden = first[0] * sfield__y00;
            } else hidden = sfield__hidden_share(f, &at, (int)l);
            out[i + l] = good >> l & 1 ? (hidden < 1 ? (hidden > 0 ? 1 - hidden : 1.0f) : 0.0f) : 1.0f;
        }
    }
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_self(const sfield_field *f, size_t first, size_t count, float *out)
{
    uint32_t k, n;
    size_t i;
    if (!f || !out) return SFIELD_ERR_ARGUMENT;
    if (f->h.kind != SFIELD_KIND_SELF) return SFIELD_ERR_BASIS;
    if (first > f->h.samples || count > f->h.samples - first) return SFIELD_ERR_ARGUMENT;
    n = f->h.basis == SFIELD_BASIS_SH ? f->h.bands * f->h.bands : 6 * f->h.cube_side * f->h.cube_side;
    for (i = 0; i < count; i++) {
        float *o = out + i * n;
        if (f->h.basis == SFIELD_BASIS_SH) {
            for (k = 0; k < n; k++) o[k] = f->scale[k] * (float)f->sample[(first + i) * f->h.stride + k] + f->bias[k];
        } else {
            float coefs[4096];
            uint32_t face, squares, m = n / 6;
            memset(o, 0, n * sizeof *o);
            sfield__scatter(f, first + i, 1, o);
            for (face = 0; face < 6; face++, o += m) {
                memcpy(coefs, o, m * sizeof *o);
                for (squares = 1; squares < m; squares *= 4) sfield__haar_up(coefs + squares, squares, o, o);
            }
        }
    }
    return SFIELD_OK;
}

/* ---- >>scene ---- */

enum { SFIELD__CACHED = 256 };      /* wavelets of T that the lazy cache keeps for a point and light */

typedef struct sfield__item {       /* of an entity */
    sfield_entity e;
    float    turn[9];               /* world to field directions, rows */
    float center[2][3], inverse[2], radius[2]; /* of occlusion and source: world center, 1 / (scale r), world radius */
    float    inscribed, reach;      /* of the occluder, world */
    int      identity;
    uint32_t map;                   /* wavelets, rotated: 1 + which resampling table */
    uint32_t crc;                   /* of the occlusion field: another one may come to lie at the same address */
} sfield__item;

typedef struct sfield__taps { uint16_t texel[4]; float weight[4]; } sfield__taps;

struct sfield_scene {
    sfield__allocator allocator;
    sfield_scene_desc desc;
    sfield_algebra   *algebra;
    int               simd;
    uint32_t          coefs, planes, cells, side;
    sfield__item     *item;
    sfield_rotation  *rotation;
    sfield__taps     *taps;
    uint32_t         *occluder, *light, item_count, occluder_count, light_count, overlaps, maps;
    uint64_t          version, sky_version;       /* of everything but lights; of the environment */
    float            *sky;          /* as set: cube of texels, 3 planes; kept unturned */
    float            *sky_now;      /* harmonics: 3 x n^2; wavelets: 3 x 6 N^2 texels, then their coefficients */
    float            *sky_still;    /* harmonics: as set, not turned */
    float            *sun;          /* likewise, not turned */
    int               has_sky, has_sun;
    float             sky_turn[16];
    float            *texel;        /* x, y, z, solid angle: four planes of 6 N^2 */
    uint8_t          *scratch;
    size_t            scratch_bytes;
};

struct sfield_cache {
    sfield__allocator allocator;
    size_t    points, bytes;
    uint32_t  lights, coefs, cells; /* cells 0: harmonics */
    uint64_t *hash;                 /* harmonics: tiles x lights; wavelets: points x lights; 0 = nothing kept */
    int16_t  *value;
    uint16_t *index;                /* wavelets: of each value */
    float    *scale;
    uint64_t *lit;                  /* wavelets: hash and sky that sky is of, 3 floats a point; harmonics: what the
                                       marks of a tile are of */
    float    *sky;
    uint8_t  *marks;                /* harmonics: of each tile, so many T on the way that all lights share are kept */
};

SFIELD_DEF sfield_entity sfield_entity_default(void)
{
    sfield_entity e;
    memset(&e, 0, sizeof e);
    e.transform[0] = e.transform[5] = e.transform[10] = e.transform[15] = 1;
    e.tint[0] = e.tint[1] = e.tint[2] = 1;
    return e;
}

static void sfield__free_lists(sfield_scene *s)
{
    sfield__free(&s->allocator, s->item);
    sfield__free(&s->allocator, s->rotation);
    sfield__free(&s->allocator, s->occluder);
    sfield__free(&s->allocator, s->light);
    sfield__free(&s->allocator, s->taps);
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
    sfield__free(&a, s);
}

SFIELD_DEF sfield_result sfield_scene_create(const sfield_scene_desc *desc, sfield_scene **out)
{
    sfield_scene_desc d;
    sfield__allocator a;
    sfield_scene *s;
    uint32_t haar, i, k;
    size_t kept;
    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    if (!out) return SFIELD_ERR_ARGUMENT;
    if (!sfield__allocator_valid(d.allocator.alloc_fn, d.allocator.free_fn)) return SFIELD_ERR_DESC;
    haar = d.basis == SFIELD_BASIS_HAAR;
    if ((uint32_t)d.basis >= SFIELD_BASIS_COUNT || (uint32_t)d.product >= SFIELD_PRODUCT_COUNT) return SFIELD_ERR_DESC;
    if (d.product == SFIELD_PRODUCT_DEFAULT) d.product = haar ? SFIELD_PRODUCT_TEXELS : SFIELD_PRODUCT_TRIPLE;
    if (haar != (d.product >= SFIELD_PRODUCT_TEXELS)) return SFIELD_ERR_DESC;
    d.bands = d.bands ? d.bands : 4;
    d.cube_side = d.cube_side ? d.cube_side : haar ? 32 : 16;
    if (d.bands > SFIELD_MAX_BANDS || !sfield__is_side(d.cube_side, 4) || !sfield__in(d.reach, 0, 1e6f))
        return SFIELD_ERR_DESC;
    a = sfield__allocator_of(&d.allocator);
    s = (sfield_scene *)sfield__alloc(&a, sizeof *s);
    if (!s) return SFIELD_ERR_ALLOC;
    memset(s, 0, sizeof *s);
    s->allocator = a;
    s->desc = d;
    s->simd = sfield__simd();
    s->side = d.cube_side;
    s->cells = 6 * s->side * s->side;
    s->coefs = haar ? s->cells : d.bands * d.bands;
    s->planes = haar ? s->cells : sfield__planes(d.bands);
    s->version = 1;
    kept = 3 * (size_t)s->cells + 3 * (size_t)s->planes * 3;
    s->sky = (float *)sfield__alloc_array(&a, kept, sizeof *s->sky);
    s->texel = (float *)sfield__alloc_array(&a, 4 * (size_t)s->cells, sizeof *s->texel);
    if (!s->sky || !s->texel || (!haar && sfield_algebra_create(d.bands, &d.allocator, &s->algebra) != SFIELD_OK)) {
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

static int sfield__field_fits(const sfield_scene *s, const sfield_field *f, sfield_kind kind)
{
    if (f->h.kind != (uint32_t)kind) return 0;
    if (f->h.basis == SFIELD_BASIS_HAAR) return s->algebra == NULL && f->h.cube_side == s->side;
    if (!s->algebra || f->h.bands != s->desc.bands) return 0;
    return kind != SFIELD_KIND_OCCLUSION || (s->desc.product == SFIELD_PRODUCT_EXP) == (f->h.logarithm != 0);
}

static void sfield__place_field(sfield__item *it, int which, const sfield_field *f, float scale)
{
    sfield__v3_store(it->center[which], sfield__m4_point(it->e.transform, sfield__v3_load(f->h.center)));
    it->radius[which] = scale * f->h.radius;
    it->inverse[which] = 1 / it->radius[which];
}

static sfield_result sfield__item_make(const sfield_scene *s, const sfield_entity *e, sfield__item *it,
                                       sfield_rotation *rotation)
{
    float scale;
    uint32_t i, k;
    memset(it, 0, sizeof *it);
    it->e = *e;
    if (!sfield__m4_is_rigid_uniform(e->transform, &scale)) return SFIELD_ERR_ARGUMENT;
    it->identity = sfield__is_upright(e->transform);
    for (i = 0; i < 3; i++) {
        if (!sfield__in(e->tint[i], -1e18f, 1e18f)) return SFIELD_ERR_ARGUMENT;
        for (k = 0; k < 3; k++)
            it->turn[3 * i + k] = it->identity ? (i == k ? 1.0f : 0.0f) : e->transform[4 * i + k] / scale;
    }
    if ((e->occlusion && e->occlusion->h.shard_end) || (e->source && e->source->h.shard_end)) return SFIELD_ERR_SHARD;
    if (e->occlusion) {
        if (!sfield__field_fits(s, e->occlusion, SFIELD_KIND_OCCLUSION)) return SFIELD_ERR_BASIS;
        sfield__place_field(it, 0, e->occlusion, scale);
        it->crc = e->occlusion->h.crc;
        it->inscribed = e->occlusion->h.inscribed * scale;
        it->reach = it->radius[0] * (s->desc.reach > 0 ? s->desc.reach
                                                       : e->occlusion->radii[e->occlusion->h.shells - 1]);
    }
    if (e->source) {
        if (!sfield__field_fits(s, e->source, SFIELD_KIND_SOURCE)) return SFIELD_ERR_BASIS;
        sfield__place_field(it, 1, e->source, scale);
    }
    if (!s->algebra) {                          /* what only receives may turn, unless it has a self-visibility */
        const int sparse = s->desc.product == SFIELD_PRODUCT_SPARSE;
        return sparse && !it->identity && (e->occlusion || e->source) ? SFIELD_ERR_ROTATION : SFIELD_OK;
    }
    return sfield_sh_rotation(s->algebra, e->transform, rotation);
}

/* For a rotated entity in wavelets: which texels of its own cube lie around each direction of the world's. */
static void sfield__taps_make(const sfield_scene *s, const float *turn, sfield__taps *taps)
{
    uint32_t i, k, face;
    for (i = 0; i < s->cells; i++) {
        float d[3], q[3], local[3], x, y;
        int32_t xi, yi;
        for (k = 0; k < 3; k++) d[k] = s->texel[k * s->cells + i];
        for (k = 0; k < 3; k++) local[k] = turn[3 * k] * d[0] + turn[3 * k + 1] * d[1] + turn[3 * k + 2] * d[2];
        face = sfield__face_of(local);
        sfield__to_face(face, local, q);
        x = (q[0] / q[2] + 1) * 0.5f * (float)s->side - 0.5f;
        y = (q[1] / q[2] + 1) * 0.5f * (float)s->side - 0.5f;
        xi = (int32_t)(x + 1) - 1;
        yi = (int32_t)(y + 1) - 1;
        x -= (float)xi;
        y -= (float)yi;
        for (k = 0; k < 4; k++) {               /* past an edge: the texel of the next face in that direction */
            double e[3];
            sfield__from_face(face, (2.0 * (xi + (int32_t)(k & 1)) + 1) / s->side - 1,
                              (2.0 * (yi + (int32_t)(k >> 1)) + 1) / s->side - 1, e);
            d[0] = (float)e[0];
            d[1] = (float)e[1];
            d[2] = (float)e[2];
            taps[i].texel[k] = (uint16_t)sfield_cube_find(s->side, d);
            taps[i].weight[k] = (k & 1 ? x : 1 - x) * (k >> 1 ? y : 1 - y);
        }
    }
}

static int sfield__same_body(const sfield__item *p, const sfield__item *q)
{
    const sfield_entity *a = &p->e, *b = &q->e;
    return a->occlusion == b->occlusion && p->crc == q->crc && (a->source == NULL) == (b->source == NULL) &&
           ((!a->occlusion && a->source) || memcmp(a->transform, b->transform, sizeof a->transform) == 0);
}

/* Lists of the new scene, made beside the old one. */
static sfield_result sfield__lists_make(sfield_scene *n, const sfield_entity *entities, size_t count)
{
    uint32_t i, j, turned = 0;
    size_t room = count ? count : 1;
    n->item = (sfield__item *)sfield__alloc_array(&n->allocator, room, sizeof *n->item);
    n->rotation = (sfield_rotation *)sfield__alloc_array(&n->allocator, n->algebra ? room : 1, sizeof *n->rotation);
    n->occluder = (uint32_t *)sfield__alloc_array(&n->allocator, room, sizeof *n->occluder);
    n->light = (uint32_t *)sfield__alloc_array(&n->allocator, room, sizeof *n->light);
    if (!n->item || !n->rotation || !n->occluder || !n->light) return SFIELD_ERR_ALLOC;
    for (i = 0; i < count; i++) {
        sfield__item *it = &n->item[i];
        sfield_result result = sfield__item_make(n, &entities[i], it, n->rotation + (n->algebra ? i : 0));
        if (result != SFIELD_OK) return result;
        if (it->e.occlusion) n->occluder[n->occluder_count++] = i;
        if (it->e.source) n->light[n->light_count++] = i;
        if (!n->algebra && !it->identity && (it->e.occlusion || it->e.source)) it->map = ++turned;
    }
    if (turned) {
        n->taps = (sfield__taps *)sfield__alloc_array(&n->allocator, (size_t)turned * n->cells, sizeof *n->taps);
        if (!n->taps) return SFIELD_ERR_ALLOC;
        for (i = 0; i < count; i++)
            if (n->item[i].map)
                sfield__taps_make(n, n->item[i].turn, n->taps + (size_t)(n->item[i].map - 1) * n->cells);
    }
    n->maps = turned;
    for (i = 0; i < n->light_count; i++)
        for (j = 0; j < n->occluder_count; j++) {
            const sfield__item *a = &n->item[n->light[i]], *b = &n->item[n->occluder[j]];
            sfield__v3 d = sfield__v3_sub(sfield__v3_load(a->center[1]), sfield__v3_load(b->center[0]));
            n->overlaps += a != b && sfield__v3_length(d) < a->radius[1] + b->radius[0];
        }
    return n->overlaps && n->desc.strict ? SFIELD_ERR_OVERLAP : SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_scene_entities(sfield_scene *s, const sfield_entity *entities, size_t count)
{
    sfield_scene n;
    sfield_result result;
    uint32_t i;
    int same;
    if (!s || (!entities && count)) return SFIELD_ERR_ARGUMENT;
    if (count > 65535) return SFIELD_ERR_LIMIT;
    n = *s;
    n.item = NULL;
    n.rotation = NULL;
    n.occluder = n.light = NULL;
    n.taps = NULL;
    n.occluder_count = n.light_count = n.overlaps = 0;
    n.item_count = (uint32_t)count;
    result = sfield__lists_make(&n, entities, count);
    if (result != SFIELD_OK) {
        sfield__free_lists(&n);
        return result;
    }
    same = count == s->item_count;
    for (i = 0; i < count && same; i++) same = sfield__same_body(&s->item[i], &n.item[i]);
    n.version = s->version + !same;
    sfield__free_lists(s);
    *s = n;
    return SFIELD_OK;
}

/* ---- >>environment ---- */

/* What a map leaves in a texel of the cube: sums by solid angle, and the least of each channel. */
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

/* A texel of the map has one radiance and its exact solid angle. It counts where its middle lies in the cube, in parts
   where the map is coarser: no sun falls between samples, none counts twice (T11, T12). */
static void sfield__gather_map(const sfield_scene *s, const float *rgb, uint32_t width, uint32_t height,
                               sfield__gathered *g)
{
    const uint32_t across = (32 * s->side + width - 1) / width, down = (16 * s->side + height - 1) / height;
    const uint32_t wide = width * across, high = height * down;
    const double step = 2 * sfield__pi / wide;
    double first[2], turn[2], half, unused, sine, cosine;
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
            sfield__gather_cell(g + sfield_cube_find(s->side, direction), row + 3 * (size_t)(x / across), angle);
            old = c;
            c = c * turn[0] - n * turn[1];
            n = n * turn[0] + old * turn[1];
        }
    }
}

/* The sky as a cube of texels. What falls into one fills its solid angle but for its edges: what all of it has at least
   counts for the whole texel, and what is brighter by the energy there is; the rest of that error is scaled away.
   0: no memory. */
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

/* The cube as it lies in the world now. Harmonics turn their coefficients; wavelets resample the cube map, once. */
static void sfield__sky_turned(sfield_scene *s)
{
    uint32_t i, c, k;
    s->sky_version++;
    if (s->algebra) {
        sfield_rotation r;
        float tile[SFIELD_MAX_COEFS * SFIELD__LANES] = { 0 };
        for (c = 0; c < 3; c++) {
            float *now = s->sky_now + c * s->planes;
            memcpy(now, s->sky_still + c * s->planes, s->coefs * sizeof *now);
            if (sfield_sh_rotation(s->algebra, s->sky_turn, &r) == SFIELD_OK) {
                sfield__tile_in(s->coefs, 1, now, 1, tile);
                sfield__rotate16(&r, tile, tile, SFIELD__LANES, 0, s->simd);
                sfield__tile_out(s->coefs, 1, tile, now, 1);
            }
            for (k = 0; k < s->coefs; k++) now[k] += s->sun[c * s->planes + k];
        }
        return;
    }
    for (i = 0; i < s->cells; i++) {
        float d[3], q[3], x, y;
        uint32_t face;
        int32_t xi, yi;
        for (k = 0; k < 3; k++)
            d[k] = s->sky_turn[4 * k] * s->texel[i] + s->sky_turn[4 * k + 1] * s->texel[s->cells + i] +
                   s->sky_turn[4 * k + 2] * s->texel[2 * s->cells + i];
        face = sfield__face_of(d);
        sfield__to_face(face, d, q);
        x = (q[0] / q[2] + 1) * 0.5f * (float)s->side - 0.5f;
        y = (q[1] / q[2] + 1) * 0.5f * (float)s->side - 0.5f;
        xi = (int32_t)(x + 1) - 1;
        yi = (int32_t)(y + 1) - 1;
        x -= (float)xi;
        y -= (float)yi;
        for (c = 0; c < 3; c++) s->sky_now[c * s->cells + i] = s->sun[c * s->cells + i];
        for (k = 0; k < 4; k++) {
            double e[3];
            float to[3], w = (k & 1 ? x : 1 - x) * (k >> 1 ? y : 1 - y);
            uint32_t from;
            sfield__from_face(face, (2.0 * (xi + (int32_t)(k & 1)) + 1) / s->side - 1,
                              (2.0 * (yi + (int32_t)(k >> 1)) + 1) / s->side - 1, e);
            to[0] = (float)e[0];
            to[1] = (float)e[1];
            to[2] = (float)e[2];
            from = sfield_cube_find(s->side, to);
            for (c = 0; c < 3; c++) s->sky_now[c * s->cells + i] += w * s->sky[c * s->cells + from];
        }
    }
    for (c = 0; c < 3; c++)
        (void)sfield_haar_forward(s->side, s->sky_now + c * s->cells, s->sky_now + (3 + c) * s->cells);
}

static int sfield__rotation_good(const float *m)
{
    float scale;
    return !m || sfield__m4_is_rigid_uniform(m, &scale);
}

static void sfield__set_turn(sfield_scene *s, const float *rotation)
{
    uint32_t i;
    float scale = 1;
    memset(s->sky_turn, 0, sizeof s->sky_turn);
    s->sky_turn[0] = s->sky_turn[5] = s->sky_turn[10] = s->sky_turn[15] = 1;
    if (rotation && sfield__m4_is_rigid_uniform(rotation, &scale))
        for (i = 0; i < 12; i++) s->sky_turn[i] = i % 4 == 3 ? 0 : rotation[i] / scale;
    sfield__sky_turned(s);
}

SFIELD_DEF sfield_result sfield_scene_environment(sfield_scene *s, const float *rgb, uint32_t width, uint32_t height,
                                                  const float rotation[16])
{
    uint32_t c;
    if (!s || !sfield__rotation_good(rotation)) return SFIELD_ERR_ARGUMENT;
    if (rgb && (width < 1 || height < 1 || width > 65536 || height > 65536)) return SFIELD_ERR_ARGUMENT;
    if (rgb && !sfield__take_map(s, rgb, width, height)) return SFIELD_ERR_ALLOC;
    if (!rgb) memset(s->sky, 0, 3 * (size_t)s->cells * sizeof *s->sky);
    memset(s->sun, 0, 3 * (size_t)s->planes * sizeof *s->sun);
    s->has_sky = rgb != NULL;
    s->has_sun = 0;
    for (c = 0; c < 3 && s->algebra; c++)
        (void)sfield_sh_project(s->desc.bands, s->side, s->sky + c * s->cells, 1, s->sky_still + c * s->planes);
    sfield__set_turn(s, rotation);
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_scene_turn(sfield_scene *s, const float rotation[16])
{
    if (!s || !rotation || !sfield__rotation_good(rotation)) return SFIELD_ERR_ARGUMENT;
    sfield__set_turn(s, rotation);
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_scene_sun(sfield_scene *s, const float direction[3], const float irradiance[3])
{
    double d[3], y[SFIELD_MAX_COEFS], length = 0;
    uint32_t c, k;
    if (!s || (direction && !irradiance)) return SFIELD_ERR_ARGUMENT;
    if (!direction) {
        memset(s->sun, 0, 3 * (size_t)s->planes * sizeof *s->sun);
        s->has_sun = 0;
        sfield__sky_turned(s);
        return SFIELD_OK;
    }
    for (k = 0; k < 3; k++) {
        if (!sfield__in(direction[k], -1.1f, 1.1f) || !sfield__in(irradiance[k], 0, 1e18f)) return SFIELD_ERR_ARGUMENT;
        d[k] = (double)direction[k];
        length += d[k] * d[k];
    }
    if (fabs(length - 1) > 1e-2) return SFIELD_ERR_ARGUMENT;
    if (s->algebra) {
        sfield_sh_basis(s->desc.bands, d, y);
        for (c = 0; c < 3; c++)
            for (k = 0; k < s->coefs; k++) s->sun[c * s->planes + k] += irradiance[c] * (float)y[k];
    } else {
        uint32_t at = sfield_cube_find(s->side, direction);
        for (c = 0; c < 3; c++) s->sun[c * s->cells + at] += irradiance[c] / s->texel[3 * s->cells + at];
    }
    if (!s->has_sky && !s->has_sun) sfield__set_turn(s, NULL);
    else sfield__sky_turned(s);
    s->has_sun = 1;
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_scene_sky(const sfield_scene *s, float *coefs)
{
    uint32_t c;
    if (!s || !coefs) return SFIELD_ERR_ARGUMENT;
    if (!s->algebra) return SFIELD_ERR_BASIS;
    for (c = 0; c < 3; c++) memcpy(coefs + c * s->coefs, s->sky_now + c * s->planes, s->coefs * sizeof *coefs);
    return SFIELD_OK;
}

/* ---- >>cache ---- */

SFIELD_DEF sfield_result sfield_cache_create(const sfield_scene *s, size_t point_count, uint32_t light_count,
                                             sfield_cache **out)
{
    sfield_cache *c;
    size_t own, units, lanes, values, bytes;
    uint8_t *at;
    if (!s || !out || !point_count || !light_count || light_count > 65536 || point_count > 0x7fffffffu)
        return SFIELD_ERR_ARGUMENT;
    own = s->algebra ? (point_count + 15) / 16 : point_count;
    if (!sfield__mul_size(own, light_count, &units) || units > SIZE_MAX / 16384) return SFIELD_ERR_ALLOC;
    lanes = units * (s->algebra ? 32 : 1);          /* marks as many as lights */
    values = lanes * (s->algebra ? s->coefs : (uint32_t)SFIELD__CACHED);
    bytes = sizeof *c + (units + own) * sizeof *c->hash + lanes * sizeof *c->scale +
            (s->algebra ? 2 * values + own : 4 * values + 3 * own * sizeof *c->sky);
    at = (uint8_t *)sfield__alloc(&s->allocator, bytes);
    if (!at) return SFIELD_ERR_ALLOC;
    c = (sfield_cache *)(void *)at;
    memset(c, 0, sizeof *c);
    c->allocator = s->allocator;
    c->points = point_count;
    c->bytes = bytes;
    c->lights = light_count;
    c->coefs = s->coefs;
    c->cells = s->algebra ? 0 : s->cells;
    c->hash = (uint64_t *)(void *)(at + sizeof *c);
    c->lit = c->hash + units;
    c->scale = (float *)(void *)(c->lit + own);
    c->sky = c->scale + lanes;
    c->value = (int16_t *)(void *)(c->sky + (s->algebra ? 0 : 3 * own));
    c->index = s->algebra ? NULL : (uint16_t *)(c->value + values);
    c->marks = (uint8_t *)(c->value + values);
    memset(c->hash, 0, (size_t)((uint8_t *)c->scale - (uint8_t *)c->hash));
    *out = c;
    return SFIELD_OK;
}

SFIELD_DEF void sfield_cache_free(sfield_cache *cache)
{
    sfield__allocator a;
    if (!cache) return;
    a = cache->allocator;
    sfield__free(&a, cache);
}

SFIELD_DEF size_t sfield_cache_bytes(const sfield_cache *cache) { return cache ? cache->bytes : 0; }

#define SFIELD__LEAST_T 1e-30f      /* below, what is kept of T is 0: 32767 over it would pass what a float holds */

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

/* What T of a set hangs on besides occluders: all bodies, and where its points stand. An entity that shines and hides
   nothing moves without a new version, since lamps do; points that lie on it move with it. */
static uint64_t sfield__stand(const sfield_scene *s, const sfield_points *set)
{
    uint64_t h = sfield__hash(s->version, (uint64_t)(uintptr_t)s);
    h = sfield__hash(h, (uint64_t)(uintptr_t)set->self);
    h = sfield__hash(h, (uint64_t)set->entity << 32 | (set->self ? set->self->h.crc : 0));
    if (set->entity != SFIELD_NONE) h = sfield__hash_bytes(h, s->item[set->entity].e.transform, 16);
    return h;
}

/* ---- >>tiles: sixteen points in harmonics ---- */

typedef struct sfield__tile {
    const sfield_scene *s;
    const sfield_points *set;
    size_t    first;
    uint32_t  lanes, active, visible;           /* how many, which can be shaded, which are wanted; bits */
    float     p[48], n[48], view[48];           /* planes, world */
    float     middle[3], extent;                /* a sphere about all lanes */
    uint32_t  count;                            /* occluders that count for some lane */
    uint32_t *item, *order, *used, *shown;      /* used: lanes for which it counts; shown: and is not hidden */
    float *mean, *widest, *farthest; /* d of the middle; of all lanes: greatest sine of the inscribed sphere, d */
    float    *d2, *factor, *occlusion;          /* 16, 16, 16 n^2 floats each */
    uint8_t  *state;                            /* 0 not looked at, 1 hides something, 2 nothing */
    uint32_t  lights;                           /* and the environment, if it is wanted, behind them */
    int       sky, chains, all_round;           /* chains: 2 with a lobe; all_round: below the horizon too */
    float    *light_d2;                         /* 16 each */
    uint16_t *mask;                             /* [light][occluder in order]: lanes for which it is nearer */
    uint64_t  stand;                            /* sfield__stand */
    uint64_t *hash, way;                        /* of what each light sees, and of all occluders; with a cache */
    uint8_t  *needed;
    uint32_t *prefix;                           /* of the order: how many are nearer than it for all their lanes */
    float    *t;                                /* [light][chain] 16 n^2 */
    float    *start;                            /* [chain] */
    float    *rows, *planes, *turned;           /* for one entity: 16 rows of 3 channels; planes twice */
    sfield_scene_stats stats;
} sfield__tile;

static const float *sfield__row(const float *base, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)(const void *)base + i * (stride ? stride : 12));
}

/* Scratch of one task, carved out of memory or (NULL) measured: of 65,535 entities no more than 2^34 bytes, which a
   size_t may not hold. */
static uint64_t sfield__carve(sfield__tile *t, uint8_t *memory, uint32_t occluders, uint32_t lights, uint32_t coefs,
                              uint32_t chains)
{
    uint64_t at = 0, c = coefs * SFIELD__LANES, n = occluders ? occluders : 1, slots = (uint64_t)lights + 1;
#define SFIELD__CARVE(member, type, number)                                \
    do {                                                                   \
        if (memory) t->member = (type *)(void *)(memory + (size_t)at);     \
        at += ((number) * sizeof(type) + 63) / 64 * 64;                    \
    } while (0)
    SFIELD__CARVE(occlusion, float, n * c);
    SFIELD__CARVE(t, float, (slots * chains > 3 ? slots * chains : 3) * c);
    SFIELD__CARVE(start, float, 2 * c);
    SFIELD__CARVE(rows, float, 3 * (c + 7 * SFIELD__LANES));        /* coefficients of a row: a multiple of 8 */
    SFIELD__CARVE(planes, float, c + 7 * SFIELD__LANES);
    SFIELD__CARVE(turned, float, c);
    SFIELD__CARVE(d2, float, n * SFIELD__LANES);
    SFIELD__CARVE(factor, float, n * SFIELD__LANES);
    SFIELD__CARVE(light_d2, float, slots * SFIELD__LANES);
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

static void sfield__load(sfield__tile *t)
{
    const sfield_points *set = t->set;
    const float *m = set->entity == SFIELD_NONE ? NULL : t->s->item[set->entity].e.transform;
    const float *turn = m ? t->s->item[set->entity].turn : NULL;
    uint32_t l, k;
    t->active = t->visible = 0;
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
        if (set->views) v = sfield__v3_load(sfield__row(set->views, set->view_stride, i));
        if (l < t->lanes && sfield__finite(sfield__v3_dot(p, p)) && sfield__v3_dot(n, n) < 1.1f &&
            sfield__v3_dot(v, v) < 1.1f && sfield__v3_dot(n, n) > 0.9f) {
            t->active |= 1u << l;
            if (!set->visible || set->visible[i]) t->visible |= 1u << l;
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

/* A sphere about the lanes that can be shaded, from the middle of their box. */
static void sfield__bound(sfield__tile *t)
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

static uint32_t sfield__bits(uint32_t mask)
{
    return sfield__popcount(mask);
}

static void sfield__distances(const float *p, const float *c, float *d2)
{
    int l;
    for (l = 0; l < SFIELD__LANES; l++) {
        float x = c[0] - p[l], y = c[1] - p[16 + l], z = c[2] - p[32 + l];
        d2[l] = x * x + y * y + z * z;
    }
}

#if SFIELD__SIMD
SFIELD__TARGET_AVX2 static uint32_t sfield__nearer16_avx2(const float *a, const float *b)
{
    int low = _mm256_movemask_ps(_mm256_cmp_ps(_mm256_loadu_ps(a), _mm256_loadu_ps(b), _CMP_LT_OQ));
    int high = _mm256_movemask_ps(_mm256_cmp_ps(_mm256_loadu_ps(a + 8), _mm256_loadu_ps(b + 8), _CMP_LT_OQ));
    return (uint32_t)(low | high << 8);
}

SFIELD__TARGET_AVX2 static uint32_t sfield__look16_avx2(const float *p, const float *n, const float *c, float reach2,
                                                        float low, float *d2)
{
    uint32_t bits = 0, l;
    for (l = 0; l < SFIELD__LANES; l += 8) {
        __m256 x = _mm256_sub_ps(_mm256_set1_ps(c[0]), _mm256_loadu_ps(p + l));
        __m256 y = _mm256_sub_ps(_mm256_set1_ps(c[1]), _mm256_loadu_ps(p + 16 + l));
        __m256 z = _mm256_sub_ps(_mm256_set1_ps(c[2]), _mm256_loadu_ps(p + 32 + l));
        __m256 d = _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(x, x), _mm256_mul_ps(y, y)), _mm256_mul_ps(z, z));
        __m256 h = _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(x, _mm256_loadu_ps(n + l)),
                                               _mm256_mul_ps(y, _mm256_loadu_ps(n + 16 + l))),
                                 _mm256_mul_ps(z, _mm256_loadu_ps(n + 32 + l)));
        _mm256_storeu_ps(d2 + l, d);
        bits |= (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(d, _mm256_set1_ps(reach2), _CMP_LT_OQ)) << l;
        bits |= (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(h, _mm256_set1_ps(low), _CMP_GT_OQ)) << (16 + l);
    }
    return bits;
}
#endif

/* Bits of lanes with a < b. */
static uint32_t sfield__nearer16(const float *a, const float *b, int simd)
{
    uint32_t l, bits = 0;
#if SFIELD__SIMD
    if (simd) return sfield__nearer16_avx2(a, b);
#endif
    (void)simd;
    for (l = 0; l < SFIELD__LANES; l++) bits |= (uint32_t)(a[l] < b[l]) << l;
    return bits;
}

/* Squared distances of the lanes to c; bits: nearer than reach, and, from 16 on, c higher above the horizon
   than low. */
static uint32_t sfield__look16(const float *p, const float *n, const float *c, float reach2, float low, float *d2,
                               int simd)
{
    uint32_t l, bits = 0;
#if SFIELD__SIMD
    if (simd) return sfield__look16_avx2(p, n, c, reach2, low, d2);
#endif
    (void)simd;
    for (l = 0; l < SFIELD__LANES; l++) {
        float x = c[0] - p[l], y = c[1] - p[16 + l], z = c[2] - p[32 + l];
        float height = x * n[l] + y * n[16 + l] + z * n[32 + l];
        d2[l] = x * x + y * y + z * z;
        bits |= (uint32_t)(d2[l] < reach2) << l | (uint32_t)(height > low) << (16 + l);
    }
    return bits;
}

#if SFIELD__SIMD
SFIELD__TARGET_AVX2 static void sfield__fade16_avx2(const float *d2, float inverse, uint32_t lanes, float *factor)
{
    const __m256 one = _mm256_set1_ps(1), four = _mm256_set1_ps(4);
    uint32_t l;
    for (l = 0; l < SFIELD__LANES; l += 8) {
        __m256 d = _mm256_mul_ps(_mm256_sqrt_ps(_mm256_loadu_ps(d2 + l)), _mm256_set1_ps(inverse));
        d = _mm256_min_ps(_mm256_mul_ps(four, _mm256_sub_ps(one, d)), one);
        _mm256_storeu_ps(factor + l, _mm256_and_ps(d, sfield__lanes8(lanes, l)));
    }
}
#endif

/* What is left of an occluder: 1 up to three quarters of its reach, 0 for lanes that do not count. */
static void sfield__fade16(const float *d2, float inverse_reach, uint32_t lanes, float *factor, int simd)
{
    uint32_t l;
#if SFIELD__SIMD
    if (simd) {
        sfield__fade16_avx2(d2, inverse_reach, lanes, factor);
        return;
    }
#endif
    (void)simd;
    for (l = 0; l < SFIELD__LANES; l++) {
        float f = 4 * (1 - sqrtf(d2[l]) * inverse_reach);
        factor[l] = lanes >> l & 1 ? (f < 1 ? f : 1.0f) : 0.0f;
    }
}

/* Occluders that count for any lane, in reach (third rule) and, but for incident radiance, not below the horizon
   (first), from near to far by the middle of the tile. */
static void sfield__candidates(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    uint32_t i, j;
    t->count = 0;
    sfield__bound(t);
    for (i = 0; i < s->occluder_count; i++) {
        const sfield__item *it = &s->item[s->occluder[i]];
        float *d2 = t->d2 + (size_t)t->count * SFIELD__LANES;
        const float *c = it->center[0], x = c[0] - t->middle[0], y = c[1] - t->middle[1], z = c[2] - t->middle[2];
        const float mean = sqrtf(x * x + y * y + z * z), least = mean - t->extent;
        uint32_t near_by = 0, used = 0;
        if (s->occluder[i] == t->set->entity) continue;
        if (least < it->reach) {
            used = sfield__look16(t->p, t->n, c, it->reach * it->reach, -it->radius[0], d2, s->simd);
            near_by = used & t->active;
            used = t->all_round ? near_by : near_by & used >> 16;
        }
        t->stats.pairs += t->lanes;
        t->stats.culled_far += sfield__bits(t->active & ~near_by);
        t->stats.culled_horizon += sfield__bits(near_by & ~used);
        if (!used) continue;
        t->farthest[t->count] = mean + t->extent;
        t->widest[t->count] = least > it->inscribed ? it->inscribed / least : 1;
        t->used[t->count] = used;
        t->item[t->count] = s->occluder[i];
        t->mean[t->count] = mean;
        t->state[t->count] = 0;
        for (j = t->count; j > 0 && t->mean[t->order[j - 1]] > mean; j--) t->order[j] = t->order[j - 1];
        t->order[j] = t->count++;
    }
}

/* What is left of each candidate for each lane. */
static void sfield__fades(sfield__tile *t)
{
    uint32_t i;
    for (i = 0; i < t->count; i++) {
        const size_t at = (size_t)i * SFIELD__LANES;
        const float reach = t->s->item[t->item[i]].reach;
        sfield__fade16(t->d2 + at, t->farthest[i] > 0.75f * reach ? 1 / reach : 0, t->used[i], t->factor + at,
                       t->s->simd);
    }
}

/* Is light j the entity that the points lie on? All of its light comes from below their horizon, or is hidden by their
   own visibility: what would be added is ringing, of the strongest light there is. */
static int sfield__is_own(const sfield__tile *t, uint32_t j)
{
    return j < t->lights && t->s->light[j] == t->set->entity;
}

/* How many lights light a set; the environment, where there is one, with them. */
static uint32_t sfield__lights_of(const sfield_scene *s, const sfield_points *set, int sky)
{
    return s->light_count + (uint32_t)sky - (set->entity != SFIELD_NONE && s->item[set->entity].e.source ? 1u : 0u);
}

/* For each light the lanes for which each occluder counts and is nearer than it. */
static void sfield__masks(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    const int cached = t->set->cache != NULL;
    uint32_t j, i;
    t->way = t->stand;
    for (i = 0; i < t->count && cached; i++)
        t->way = sfield__hash(t->way, (uint64_t)t->item[t->order[i]] << 16 | t->used[t->order[i]]);
    t->way |= 1;
    for (j = 0; j < t->lights + (uint32_t)t->sky; j++) {
        uint16_t *mask = t->mask + (size_t)j * (s->occluder_count ? s->occluder_count : 1);
        float *light = t->light_d2 + (size_t)j * SFIELD__LANES;
        uint32_t own = j < t->lights ? s->light[j] : SFIELD_NONE, prefix = 0;
        if (sfield__is_own(t, j)) continue;
        if (j < t->lights) sfield__distances(t->p, s->item[own].center[1], light);
        t->hash[j] = t->stand;
        for (i = 0; i < t->count; i++) {
            const uint32_t o = t->order[i], used = t->used[o];
            uint32_t bits = used;
            if (j < t->lights)
                bits =
                    t->item[o] == own ? 0 : used & sfield__nearer16(t->d2 + (size_t)o * SFIELD__LANES, light, s->simd);
            mask[i] = (uint16_t)bits;
            prefix += prefix == i && bits == used;
            if (bits && cached) t->hash[j] = sfield__hash(t->hash[j], (uint64_t)t->item[o] << 16 | bits);
        }
        t->hash[j] |= 1;
        t->prefix[j] = prefix;
    }
}

/* Is no line from a lane to the middle of a in the inscribed sphere of b? Those lines are nowhere farther from that of
   the tile's middle than the lanes are. */
static int sfield__is_aside(const sfield__tile *t, const sfield__item *a, const sfield__item *b)
{
    const sfield__v3 m = sfield__v3_load(t->middle), v = sfield__v3_sub(sfield__v3_load(a->center[0]), m);
    const sfield__v3 c = sfield__v3_cross(v, sfield__v3_sub(sfield__v3_load(b->center[0]), m));
    const float most = 1.001f * (b->inscribed + t->extent);
    return sfield__v3_dot(c, c) > most * most * sfield__v3_dot(v, v);
}

/* Second rule: lanes of a mask for which the bounding sphere of occluder i is inside the cone of a nearer inscribed
   one. */
static uint32_t sfield__hidden(const sfield__tile *t, uint32_t i, uint32_t lanes)
{
    const sfield__item *a = &t->s->item[t->item[i]];
    const float a2 = a->radius[0] * a->radius[0], *near_i = t->d2 + i * SFIELD__LANES;
    uint32_t j, l, k, hidden = 0;
    for (j = 0; j < t->count; j++) {
        const sfield__item *b = &t->s->item[t->item[j]];
        const float b2 = b->inscribed * b->inscribed, *near_j = t->d2 + j * SFIELD__LANES;
        if (!(t->widest[j] * t->farthest[i] > a->radius[0]) || j == i) continue;      /* for no lane */
        if (sfield__is_aside(t, a, b)) continue;
        for (l = 0; l < SFIELD__LANES; l++) {
            float d2 = near_i[l], e2 = near_j[l], dot = 0, sines, cosines;
            if (!((lanes & ~hidden) >> l & 1) || e2 >= d2 || a2 >= d2 || b2 >= e2 || b2 * d2 <= a2 * e2) continue;
            if (t->factor[j * SFIELD__LANES + l] < 1) continue;
            for (k = 0; k < 3; k++) dot += (a->center[0][k] - t->p[16 * k + l]) * (b->center[0][k] - t->p[16 * k + l]);
            sines = a->radius[0] * b->inscribed;
            cosines = sqrtf((d2 - a2) * (e2 - b2));
            if (dot >= cosines + sines) hidden |= 1u << l;
        }
    }
    return hidden;
}

#if SFIELD__SIMD
SFIELD__TARGET_AVX2 static void sfield__to_local_avx2(const float *m, const float *c, float f, const float *p,
                                                      float *local)
{
    uint32_t l, k;
    for (l = 0; l < SFIELD__LANES; l += 8) {
        const __m256 s = _mm256_set1_ps(f);
        const __m256 x = _mm256_mul_ps(_mm256_sub_ps(_mm256_loadu_ps(p + l), _mm256_set1_ps(c[0])), s);
        const __m256 y = _mm256_mul_ps(_mm256_sub_ps(_mm256_loadu_ps(p + 16 + l), _mm256_set1_ps(c[1])), s);
        const __m256 z = _mm256_mul_ps(_mm256_sub_ps(_mm256_loadu_ps(p + 32 + l), _mm256_set1_ps(c[2])), s);
        for (k = 0; k < 3; k++) {
            const __m256 a = _mm256_mul_ps(_mm256_set1_ps(m[3 * k]), x);
            const __m256 b = _mm256_mul_ps(_mm256_set1_ps(m[3 * k + 1]), y);
            const __m256 e = _mm256_mul_ps(_mm256_set1_ps(m[3 * k + 2]), z);
            _mm256_storeu_ps(local + 16 * k + l, _mm256_add_ps(_mm256_add_ps(a, b), e));
        }
    }
}
#endif

/* Where the lanes are in a field of an entity: planes, about its center, in r. */
static void sfield__to_local(const sfield__item *it, int which, const float *p, float *local, int simd)
{
    const float *c = it->center[which], *m = it->turn, f = it->inverse[which];
    int l;
#if SFIELD__SIMD
    if (simd) {
        sfield__to_local_avx2(m, c, f, p, local);
        return;
    }
#endif
    (void)simd;
    for (l = 0; l < SFIELD__LANES; l++) {
        float x = (p[l] - c[0]) * f, y = (p[16 + l] - c[1]) * f, z = (p[32 + l] - c[2]) * f;
        local[l] = m[0] * x + m[1] * y + m[2] * z;
        local[16 + l] = m[3] * x + m[4] * y + m[5] * z;
        local[32 + l] = m[6] * x + m[7] * y + m[8] * z;
    }
}

/* Some lanes of a field at their places, times a factor, in planes; the others are 0. */
static void sfield__fetch16(const sfield_field *f, const sfield__place *at, uint32_t lanes, const float *factor,
                            float *rows, float *planes, int simd)
{
    const uint32_t n = f->planes;
    uint32_t group[SFIELD__LANES], count = sfield__eights(at, lanes, group, simd), i, l;
    for (i = 0; i < count; i++) {
        sfield__eight e;
        float own[SFIELD__LANES];
        for (l = 0; !(group[i] >> l & 1);) l++;
        sfield__eight_load(f, (size_t)at->base[l], (size_t)at->shell[l], 0, n, &e, simd);
        sfield__select16(factor, SFIELD__LANES, group[i], own, simd);
        sfield__eight_mix(&e, at, own, i > 0, planes, simd);
    }
    if (count) return;
    for (l = 0; l < SFIELD__LANES; l++, rows += n) {
        float b[4];
        if (!(lanes >> l & 1)) {
            memset(rows, 0, n * sizeof *rows);
            continue;
        }
        sfield__corners(at, (int)l, b);
        sfield__mix(f, (size_t)at->base[l], (size_t)at->shell[l], b, at->w0[l] * factor[l], at->w1[l] * factor[l], n,
                    rows, simd);
    }
    sfield__turn(rows - SFIELD__LANES * n, n, planes, simd);
}

/* Alpha (or log visibility) of occluder i for all lanes, in planes, in the world. */
static void sfield__occlude(sfield__tile *t, uint32_t i)
{
    const sfield_scene *s = t->s;
    const sfield__item *it = &s->item[t->item[i]];
    float local[48], *planes = it->identity && s->planes == s->coefs ? NULL : t->planes;
    float *out = t->occlusion + (size_t)i * s->coefs * SFIELD__LANES;
    sfield__place at;
    uint32_t hidden;
    if (t->state[i]) return;
    hidden = sfield__hidden(t, i, t->used[i]);
    t->stats.culled_hidden += sfield__bits(hidden);
    t->shown[i] = t->used[i] & ~hidden;
    t->state[i] = t->shown[i] ? 1 : 2;
    if (!t->shown[i]) return;
    sfield__to_local(it, 0, t->p, local, s->simd);
    sfield__locate16(it->e.occlusion, local, &at, s->simd);
    sfield__fetch16(it->e.occlusion, &at, t->shown[i], t->factor + (size_t)i * SFIELD__LANES, t->rows,
                    planes ? planes : out, s->simd);
    if (!planes) return;
    if (it->identity) memcpy(out, planes, s->coefs * SFIELD__LANES * sizeof *out);
    else sfield__rotate16(&s->rotation[t->item[i]], planes, out, SFIELD__LANES, 0, s->simd);
}

/* t *= visibility of occluder i for the lanes of a mask. */
static void sfield__apply(sfield__tile *t, uint32_t i, uint32_t mask, float *chain)
{
    const sfield_scene *s = t->s;
    const float *o = t->occlusion + (size_t)i * s->coefs * SFIELD__LANES;
    int c;
    if (t->state[i] == 2 || !mask) return;
    if (mask != t->used[i]) {
        sfield__select16(o, s->coefs * SFIELD__LANES, mask, t->turned, s->simd);
        o = t->turned;
    }
    t->stats.products += sfield__bits(mask);
    for (c = 0; c < t->chains; c++, chain += s->coefs * SFIELD__LANES)
        sfield__product16(s->algebra, chain, o, chain, SFIELD__LANES, 1);
}

/* Basis at 16 directions in planes, in float. */
static void sfield__basis16(uint32_t bands, const float *d, float *out)
{
    float cm[16], sm[16], older[16], now[16], diagonal = sfield__y00;
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

/* Lobe cos^n about the mirrored view, times (n + 2) / 2 pi: its moments over x = cos are 1/(n+1), 1/(n+2) and then
   I_l = I_(l-2) (n - l + 2) / (n + l + 1). */
static void sfield__lobe(const sfield__tile *t, float *out)
{
    const sfield_points *set = t->set;
    uint32_t bands = t->s->desc.bands, i, l, k;
    float d[48], before[16], now[16], n[16];
    for (i = 0; i < 16; i++) {
        size_t at = t->first + (i < t->lanes ? i : 0);
        float dot = 0;
        for (k = 0; k < 3; k++) dot += t->n[16 * k + i] * t->view[16 * k + i];
        for (k = 0; k < 3; k++) d[16 * k + i] = 2 * dot * t->n[16 * k + i] - t->view[16 * k + i];
        n[i] = *(const float *)(const void *)((const char *)(const void *)set->exponents + at * set->exponent_stride);
        n[i] = n[i] > 1 ? (n[i] < 1000 ? n[i] : 1000) : 1;
        before[i] = (n[i] + 2) / (n[i] + 1);
        now[i] = 1;
    }
    sfield__basis16(bands, d, out);
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

/* T before any other entity: visibility of the own object times cosine, and that times the lobe. */
static void sfield__start(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    const sfield_field *self = t->set->self;
    uint32_t k, l, i, n = s->coefs * SFIELD__LANES;
    if (self) {
        for (i = 0; i < SFIELD__LANES; i++) {
            const uint8_t *q = self->sample + (t->first + (i < t->lanes ? i : 0)) * self->h.stride;
            for (k = 0; k < s->coefs; k++)
                t->start[k * SFIELD__LANES + i] = self->scale[k] * (float)q[k] + self->bias[k];
        }
        if (t->set->entity != SFIELD_NONE && !s->item[t->set->entity].identity)
            sfield__rotate16(&s->rotation[t->set->entity], t->start, t->start, SFIELD__LANES, 0, s->simd);
    } else {
        float factor[SFIELD_MAX_BANDS];
        sfield_sh_cosine(s->desc.bands, factor);
        sfield__basis16(s->desc.bands, t->n, t->start);
        for (l = 0, k = 0; l < s->desc.bands; l++)
            for (; k < (l + 1) * (l + 1) * SFIELD__LANES; k++) t->start[k] *= factor[l];
    }
    if (t->chains == 2) {
        sfield__lobe(t, t->start + n);
        sfield__product16(s->algebra, t->start, t->start + n, t->start + n, SFIELD__LANES, 0);
    }
}

static void sfield__keep(sfield_cache *c, size_t slot, const float *t)
{
    uint32_t k, l;
    int16_t *value = c->value + slot * c->coefs * SFIELD__LANES;
    for (l = 0; l < SFIELD__LANES; l++) {
        float most = 0, inverse;
        for (k = 0; k < c->coefs; k++) {
            float x = fabsf(t[k * SFIELD__LANES + l]);
            most = x > most ? x : most;
        }
        c->scale[slot * SFIELD__LANES + l] = most / 32767;
        inverse = most > SFIELD__LEAST_T ? 32767 / most : 0;
        for (k = 0; k < c->coefs; k++) {
            float q = t[k * SFIELD__LANES + l] * inverse;
            value[k * SFIELD__LANES + l] = (int16_t)(q + (q < 0 ? -0.5f : 0.5f));
        }
    }
}

static void sfield__recall(const sfield_cache *c, size_t slot, float *t, int simd)
{
    const int16_t *value = c->value + slot * c->coefs * SFIELD__LANES;
    const float *scale = c->scale + slot * SFIELD__LANES;
    uint32_t k, l;
#if SFIELD__SIMD
    if (simd) {
        (simd == 2 ? sfield__recall_avx512 : sfield__recall_avx2)(value, scale, c->coefs * SFIELD__LANES, t);
        return;
    }
#endif
    (void)simd;
    for (k = 0; k < c->coefs * SFIELD__LANES; k += SFIELD__LANES)
        for (l = 0; l < SFIELD__LANES; l++) t[k + l] = (float)value[k + l] * scale[l];
}

/* Where T after `number` steps of the way is kept: behind what lights keep. */
static size_t sfield__mark_slot(const sfield_cache *c, size_t tile, uint32_t number)
{
    return ((c->points + 15) / 16 + tile) * c->lights + number - 1;
}

/* Figure 5 of the paper for 16 points: occluders from near to far; a light takes the T of the moment. Occluders commute
   up to truncation and are ordered for the tile; which of them are nearer than a light is decided lane by lane. */
static void sfield__chain(sfield__tile *t, sfield_cache *cache)
{
    const sfield_scene *s = t->s;
    const size_t size = (size_t)t->chains * s->coefs * SFIELD__LANES, tile = t->first / SFIELD__LANES;
    const uint32_t n = t->count, slots = t->lights + (uint32_t)t->sky;
    uint32_t step = n + 1, from = 0, last = 0, least = n, i, j, a, b;
    float *now = t->start;
    for (j = 0; j < slots; j++) {
        if (!t->needed[j]) continue;
        least = t->prefix[j] < least ? t->prefix[j] : least;
        for (i = n; i-- > last;)
            if (t->mask[(size_t)j * s->occluder_count + i]) last = i + 1;
    }
    if (cache) {
        step = n / ((cache->lights < 255 ? cache->lights : 255) + 1) + 1;
        if (cache->lit[tile] != t->way) cache->marks[tile] = 0;
        cache->lit[tile] = t->way;
        from = least / step < cache->marks[tile] ? least / step : cache->marks[tile];
        if (from) sfield__recall(cache, sfield__mark_slot(cache, tile, from), now, s->simd);
        from *= step;
    }
    if (!from) sfield__start(t);
    for (i = from; i < last; i++) sfield__occlude(t, t->order[i]);
    for (i = from; i <= last; i++) {
        if (i > from && i % step == 0) {        /* rounded always, so that a later start from here is the same */
            const size_t slot = sfield__mark_slot(cache, tile, i / step);
            sfield__keep(cache, slot, now);
            sfield__recall(cache, slot, now, s->simd);
            if (cache->marks[tile] < i / step) cache->marks[tile] = (uint8_t)(i / step);
        }
        for (j = 0; j < slots; j++) {
            const uint16_t *mask = t->mask + (size_t)j * s->occluder_count;
            float *light = t->t + j * size;
            if (!t->needed[j]) continue;
            a = t->prefix[j] < last ? t->prefix[j] : last;
            if (a != i) continue;
            for (b = last; b > a && !mask[b - 1]; b--) { }
            memcpy(light, now, size * sizeof *light);
            for (; a < b; a++) sfield__apply(t, t->order[a], mask[a], light);
        }
        if (i < last) sfield__apply(t, t->order[i], t->used[t->order[i]], now);
    }
}

/* The same by logarithms: their sum, one exp and one product for each light. */
static void sfield__chain_exp(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    uint32_t n = s->coefs * SFIELD__LANES, slots = t->lights + (uint32_t)t->sky, i, j, k, l;
    size_t size = (size_t)t->chains * n;
    float *sum = t->turned;
    int c;
    sfield__start(t);
    for (i = 0; i < t->count; i++) sfield__occlude(t, t->order[i]);
    for (j = 0; j < slots; j++) {
        if (!t->needed[j]) continue;
        memset(sum, 0, n * sizeof *sum);
        for (i = 0; i < t->count; i++) {
            uint32_t mask = t->mask[(size_t)j * s->occluder_count + i];
            const float *o = t->occlusion + (size_t)t->order[i] * n;
            if (t->state[t->order[i]] == 2 || !mask) continue;
            for (k = 0; k < n; k += SFIELD__LANES)
                for (l = 0; l < SFIELD__LANES; l++) sum[k + l] += mask >> l & 1 ? o[k + l] : 0.0f;
        }
        sfield__exp16(s->algebra, sum, sum);
        t->stats.products += sfield__bits(t->active);
        for (c = 0; c < t->chains; c++)
            sfield__product16(s->algebra, t->start + (size_t)c * n, sum, t->t + j * size + (size_t)c * n, SFIELD__LANES,
                              0);
    }
}

/* Adds a source's dot products with T, of one channel where the others are multiples of it. */
static void sfield__add_source(const sfield__item *it, const float *sum, float *rgb)
{
    const sfield_field *f = it->e.source;
    uint32_t c;
    for (c = 0; c < 3; c++)
        rgb[c * SFIELD__LANES] += it->e.tint[c] * (f->tone < 3 ? f->ratio[c] * sum[f->tone] : sum[c]);
}

#if SFIELD__SIMD
/* The dot products of a place in a source with T, lane by lane: T is turned once and the coefficients are
   never stored. */
static void sfield__shine_avx2(const sfield__tile *t, const sfield__item *it, const sfield__place *at,
                               const float *chain, float *rgb)
{
    const sfield_field *f = it->e.source;
    const uint32_t n = t->s->coefs, shells = f->h.shells;
    const size_t samples = 6 * (size_t)f->h.position_side * f->h.position_side * shells;
    uint32_t l, k, before, after;
    float time = sfield__frames_at(f, it->e.time, &before, &after);
    for (k = 0; k < n; k += 8)
        for (l = 0; l < SFIELD__LANES; l += 8)
            sfield__turn8_avx2(chain + k * SFIELD__LANES + l, SFIELD__LANES, t->rows + l * n + k, n);
    for (l = 0; l < t->lanes; l++) {
        float b[4], sum[3] = { 0, 0, 0 }, w0 = at->w0[l], w1 = at->w1[l];
        size_t base = (size_t)at->base[l], shell = (size_t)at->shell[l];
        sfield__corners(at, (int)l, b);
        sfield__mix_dot_avx2(f, before * samples + base, before * shells + shell, b, w0 * (1 - time), w1 * (1 - time),
                             t->rows + l * n, n, sum);
        if (time > 0)
            sfield__mix_dot_avx2(f, after * samples + base, after * shells + shell, b, w0 * time, w1 * time,
                                 t->rows + l * n, n, sum);
        sfield__add_source(it, sum, rgb + l);
    }
}
#endif

/* The same for the wanted lanes where they share samples, without turning T; 0, and nothing done, where they do not. */
static int sfield__shine_shared(const sfield__tile *t, const sfield__item *it, const sfield__place *at,
                                const float *chain, float *rgb)
{
    const sfield_field *f = it->e.source;
    const uint32_t n = t->s->coefs, shells = f->h.shells, every = f->tone < 3;
    const size_t samples = 6 * (size_t)f->h.position_side * f->h.position_side * shells;
    uint32_t group[SFIELD__LANES], frame[2], i, k, c, l;
    uint32_t count = sfield__eights(at, t->visible, group, t->s->simd);
    float sum[3][SFIELD__LANES] = { { 0 } }, weight[2][SFIELD__LANES], own[SFIELD__LANES];
    float time = sfield__frames_at(f, it->e.time, &frame[0], &frame[1]);
    for (l = 0; l < SFIELD__LANES; l++) {
        weight[0][l] = 1 - time;
        weight[1][l] = time;
    }
    for (i = 0; i < count; i++) {
        for (l = 0; !(group[i] >> l & 1);) l++;
        for (k = 0; k < (time > 0 ? 2u : 1u); k++) {
            sfield__select16(weight[k], SFIELD__LANES, group[i], own, t->s->simd);
            for (c = every ? f->tone : 0; c < (every ? f->tone + 1 : 3); c++) {
                sfield__eight e;
                sfield__eight_load(f, frame[k] * samples + (size_t)at->base[l],
                                   frame[k] * shells + (size_t)at->shell[l], c * n, n, &e, t->s->simd);
                sfield__eight_dot(&e, at, own, chain, sum[c], t->s->simd);
            }
        }
    }
    for (c = 0; c < 3 && count; c++)
        for (l = 0; l < SFIELD__LANES; l++)
            rgb[c * SFIELD__LANES + l] += it->e.tint[c] * (every ? f->ratio[c] * sum[f->tone][l] : sum[c][l]);
    return count != 0;
}

/* rgb += T . source of light j, three channels. */
static void sfield__shine(const sfield__tile *t, uint32_t j, const float *chain, float *rgb)
{
    const sfield_scene *s = t->s;
    const sfield__item *it = &s->item[s->light[j]];
    const sfield_field *f = it->e.source;
    float local[48], *rows = t->rows;
    sfield__place at;
    uint32_t l, c, k;
    sfield__to_local(it, 1, t->p, local, s->simd);
    sfield__locate16(f, local, &at, s->simd);
    if (!it->identity) {
        sfield__rotate16(&s->rotation[s->light[j]], chain, t->turned, SFIELD__LANES, 1, s->simd);
        chain = t->turned;
    }
    if (s->coefs % 8 == 0 && sfield__shine_shared(t, it, &at, chain, rgb)) return;
#if SFIELD__SIMD
    if (s->simd && s->coefs % 8 == 0) {
        sfield__shine_avx2(t, it, &at, chain, rgb);
        return;
    }
#endif
    for (l = 0; l < SFIELD__LANES; l++)
        sfield__fetch(f, &at, (int)l, it->e.time, f->h.stride, rows + l * f->h.stride, s->simd);
    for (l = 0; l < SFIELD__LANES; l++) {
        float sum[3] = { 0, 0, 0 };
        for (c = 0; c < 3; c++) {
            const float *row = rows + l * f->h.stride + c * s->planes;
            if (f->tone < 3 && c != f->tone) continue;
            for (k = 0; k < s->coefs; k++) sum[c] += row[k] * chain[k * SFIELD__LANES + l];
        }
        sfield__add_source(it, sum, rgb + l);
    }
}

static void sfield__sum_lights(const sfield__tile *t, int chain, float *rgb)
{
    const sfield_scene *s = t->s;
    uint32_t j, c, k, l, n = s->coefs * SFIELD__LANES;
    memset(rgb, 0, 3 * SFIELD__LANES * sizeof *rgb);
    for (j = 0; j < t->lights; j++)
        if (!sfield__is_own(t, j))
            sfield__shine(t, j, t->t + ((size_t)j * (size_t)t->chains + (size_t)chain) * n, rgb);
    if (!s->has_sky && !s->has_sun) return;
    for (c = 0; c < 3; c++) {
        const float *sky = s->sky_now + c * s->planes;
        const float *light = t->t + ((size_t)t->lights * (size_t)t->chains + (size_t)chain) * n;
        for (k = 0; k < s->coefs; k++)
            for (l = 0; l < SFIELD__LANES; l++) rgb[c * SFIELD__LANES + l] += sky[k] * light[k * SFIELD__LANES + l];
    }
}

static void sfield__store(const sfield__tile *t, const float *rgb, float factor, float *out)
{
    uint32_t l, c;
    for (l = 0; l < t->lanes; l++)
        for (c = 0; c < 3; c++)
            out[3 * (t->first + l) + c] = t->visible >> l & 1 ? rgb[c * SFIELD__LANES + l] * factor : 0.0f;
}

static void sfield__outputs(sfield__tile *t)
{
    const sfield_points *set = t->set;
    float rgb[3 * SFIELD__LANES];
    uint32_t l, n = t->s->coefs * SFIELD__LANES;
    const float *sky = t->t + (size_t)t->lights * (size_t)t->chains * n;
    if (set->rgb) {
        sfield__sum_lights(t, 0, rgb);
        sfield__store(t, rgb, 0.318309886f, set->rgb);
    }
    if (set->gloss) {
        if (t->chains == 2) sfield__sum_lights(t, 1, rgb);
        else memset(rgb, 0, sizeof rgb);
        sfield__store(t, rgb, 1, set->gloss);
    }
    for (l = 0; l < t->lanes && set->ambient; l++)
        set->ambient[t->first + l] = t->visible >> l & 1 ? sky[l] * 0.318309886f / sfield__y00 : 0.0f;
}

static void sfield__shade_tile(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    const uint32_t slots = t->lights + (uint32_t)t->sky;
    const size_t size = (size_t)t->chains * s->coefs * SFIELD__LANES;
    sfield_cache *cache = t->chains == 1 ? t->set->cache : NULL;
    uint32_t j, needed = 0;
    sfield__load(t);
    if (!t->visible) {
        memset(t->t, 0, (size_t)(t->lights + 1) * size * sizeof *t->t);
        sfield__outputs(t);
        return;
    }
#if SFIELD__SIMD
    if (cache) {                                /* on its way while occluders are looked through */
        const char *kept = (const char *)(cache->value + t->first * cache->lights * s->coefs);
        const size_t bytes = 2 * SFIELD__LANES * (size_t)cache->lights * s->coefs;
        size_t i;
        for (i = 0; i < bytes && i < 8192; i += 64) _mm_prefetch(kept + i, _MM_HINT_T0);
    }
#endif
    t->stats.points += sfield__bits(t->visible);
    t->stats.lights += (uint64_t)sfield__bits(t->visible) * sfield__lights_of(s, t->set, t->sky);
    sfield__candidates(t);
    sfield__masks(t);
    for (j = 0; j < slots; j++) {
        size_t slot = t->first / SFIELD__LANES * (cache ? cache->lights : 0) + j;
        t->needed[j] = 0;
        if (sfield__is_own(t, j)) continue;
        t->needed[j] = !cache || j >= cache->lights || cache->hash[slot] != t->hash[j];
        needed += t->needed[j];
        if (!t->needed[j]) t->stats.reused += sfield__bits(t->visible);
    }
    if (needed) {
        sfield__fades(t);
        if (s->desc.product == SFIELD_PRODUCT_EXP) sfield__chain_exp(t);
        else sfield__chain(t, cache);
    }
    for (j = 0; cache && j < slots && j < cache->lights; j++) {     /* fresh ones too, so that both are equal */
        size_t slot = t->first / SFIELD__LANES * cache->lights + j;
        if (sfield__is_own(t, j)) continue;
        if (t->needed[j]) {
            sfield__keep(cache, slot, t->t + j * size);
            cache->hash[slot] = t->hash[j];
        }
        sfield__recall(cache, slot, t->t + j * size, s->simd);
    }
    sfield__outputs(t);
}

/* Far to near (paper 3.2): the radiance so far is hidden by each occluder on the way and joined by each light. Three
   channels, 16 points. Lanes that disagree about the order of a light and an occluder go their own way: the light's T
   of the chain above is 1 there, so the order is made lane by lane. */
static void sfield__incident_tile(sfield__tile *t, float *out)
{
    const sfield_scene *s = t->s;
    uint32_t n = s->coefs * SFIELD__LANES, i, j, k, l, c, slots;
    float *sum = t->t, *rows = t->rows, local[48];
    uint32_t done[SFIELD__LANES];
    sfield__load(t);
    sfield__candidates(t);
    sfield__masks(t);
    slots = t->lights;
    sfield__fades(t);
    for (i = 0; i < t->count; i++) sfield__occlude(t, t->order[i]);
    for (c = 0; c < 3; c++)
        for (k = 0; k < s->coefs; k++)
            for (l = 0; l < SFIELD__LANES; l++)
                sum[c * n + k * SFIELD__LANES + l] = s->has_sky || s->has_sun ? s->sky_now[c * s->planes + k] : 0.0f;
    memset(done, 0, sizeof done);
    for (i = t->count + 1; i-- > 0;) {
        /* lights that in some lane lie just before occluder i - 1, or, at 0, are left */
        for (j = 0; j < slots; j++) {
            const sfield__item *it = &s->item[s->light[j]];
            const sfield_field *f = it->e.source;
            float *planes = t->planes;
            sfield__place at;
            uint32_t lanes = 0;
            if (sfield__is_own(t, j)) continue;
            for (l = 0; l < SFIELD__LANES; l++) {
                uint32_t first = 0;             /* occluders from `first` on lie behind the light for this lane */
                for (k = t->count; k > 0 && !first; k--)
                    if (t->mask[(size_t)j * s->occluder_count + k - 1] >> l & 1) first = k;
                lanes |= (uint32_t)(first == i) << l;
            }
            if (!(lanes & t->active)) continue;
            sfield__to_local(it, 1, t->p, local, s->simd);
            sfield__locate16(f, local, &at, s->simd);
            for (l = 0; l < SFIELD__LANES; l++)
                sfield__fetch(f, &at, (int)l, it->e.time, f->h.stride, rows + l * f->h.stride, s->simd);
            for (c = 0; c < 3; c++) {
                for (k = 0; k < s->coefs; k++)
                    for (l = 0; l < SFIELD__LANES; l++)
                        planes[k * SFIELD__LANES + l] =
                            lanes >> l & 1 ? it->e.tint[c] * rows[l * f->h.stride + c * s->planes + k] : 0.0f;
                if (!it->identity)
                    sfield__rotate16(&s->rotation[s->light[j]], planes, planes, SFIELD__LANES, 0, s->simd);
                for (k = 0; k < n; k++) sum[c * n + k] += planes[k];
            }
        }
        if (i == 0 || t->state[t->order[i - 1]] == 2) continue;
        t->stats.products += 3 * sfield__bits(t->active);
        for (c = 0; c < 3; c++)
            sfield__product16(s->algebra, sum + c * n, t->occlusion + (size_t)t->order[i - 1] * n, sum + c * n,
                              SFIELD__LANES, 1);
    }
    for (l = 0; l < t->lanes; l++)
        for (c = 0; c < 3; c++)
            for (k = 0; k < s->coefs; k++)
                out[((t->first + l) * 3 + c) * s->coefs + k] =
                    t->visible >> l & 1 ? sum[c * n + k * SFIELD__LANES + l] : 0.0f;
}

/* ---- >>texels: one point in wavelets ---- */

typedef struct sfield__ray {
    float d2;
    uint32_t item;
    int light;
} sfield__ray; /* light: its number, -1 an occluder */

typedef struct sfield__point {
    const sfield_scene *s;
    const sfield_points *set;
    float       *t, *haar, *coefs, *work;       /* 6 N^2, 6 N^2, 3 x 6 N^2, 6 N^2 */
    uint8_t     *marks;                         /* six faces of SFIELD__MARKS */
    sfield__ray *ray;
    float       *rgb;                           /* of one point */
    uint64_t     stand;                         /* sfield__stand */
    sfield_scene_stats stats;
} sfield__point;

static size_t sfield__carve_point(sfield__point *p, uint8_t *memory, uint32_t rays, uint32_t cells)
{
    size_t floats = 6 * (size_t)cells;
    if (memory) {
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

/* Texels of a square times 1 - the function below it. */
static void sfield__shade_square(const float *coefs, const uint8_t *marks, uint32_t leaves, float mean,
                                 uint32_t squares, uint32_t i, float scale, float *t)
{
    uint32_t k, n = 4 * leaves / squares;
    const float *w = coefs + squares + 3 * i;
    if (!marks[sfield__mark_base(squares) + i]) {
        float keep = 1 - mean;
        for (k = 0; mean != 0 && k < n; k++) t[n * i + k] *= keep;
        return;
    }
    for (k = 0; k < 4; k++) {
        float x = k & 1 ? -scale : scale, y = k & 2 ? -scale : scale, z = k == 0 || k == 3 ? scale : -scale;
        float m = mean + x * w[0] + y * w[1] + z * w[2];
        if (squares == leaves) t[4 * i + k] *= 1 - m;
        else sfield__shade_square(coefs, marks, leaves, m, 4 * squares, 4 * i + k, 2 * scale, t);
    }
}

#if SFIELD__SIMD
/* The same of a square that is marked, four quarters at a time. */
SFIELD__TARGET_AVX2 static void sfield__shade_square_avx2(const float *coefs, const uint8_t *marks, uint32_t leaves,
                                                          float mean, uint32_t squares, uint32_t i, float scale,
                                                          float *t)
{
    const __m128 sx = _mm_setr_ps(0, -0.0f, 0, -0.0f), sy = _mm_setr_ps(0, 0, -0.0f, -0.0f), one = _mm_set1_ps(1);
    const float *w = coefs + squares + 3 * i;
    const uint8_t *below = marks + sfield__mark_base(4 * squares) + 4 * i;
    uint32_t k, j, n = leaves / squares;
    __m128 m = _mm_add_ps(_mm_set1_ps(mean), _mm_xor_ps(_mm_set1_ps(scale * w[0]), sx));
    float means[4];
    m = _mm_add_ps(m, _mm_xor_ps(_mm_set1_ps(scale * w[1]), sy));
    m = _mm_add_ps(m, _mm_xor_ps(_mm_set1_ps(scale * w[2]), _mm_xor_ps(sx, sy)));
    if (n == 1) {
        _mm_storeu_ps(t + 4 * i, _mm_mul_ps(_mm_loadu_ps(t + 4 * i), _mm_sub_ps(one, m)));
        return;
    }
    _mm_storeu_ps(means, m);
    for (k = 0; k < 4; k++) {
        float *quarter = t + (4 * i + k) * (size_t)n;
        if (below[k]) sfield__shade_square_avx2(coefs, marks, leaves, means[k], 4 * squares, 4 * i + k, 2 * scale, t);
        else if (means[k] != 0)
            for (j = 0; j < n; j += 4)
                _mm_storeu_ps(quarter + j, _mm_mul_ps(_mm_loadu_ps(quarter + j), _mm_set1_ps(1 - means[k])));
    }
}
#endif

static void sfield__shade_faces(const sfield__point *p)
{
    const uint32_t side = p->s->side, n = side * side;
    uint32_t face;
    for (face = 0; face < 6; face++) {
        const float *coefs = p->coefs + face * n, mean = coefs[0] / (float)side;
        const uint8_t *marks = p->marks + face * SFIELD__MARKS;
#if SFIELD__SIMD
        if (p->s->simd && marks[0]) {
            sfield__shade_square_avx2(coefs, marks, n / 4, mean, 1, 0, 1 / (float)side, p->t + face * n);
            continue;
        }
#endif
        sfield__shade_square(coefs, marks, n / 4, mean, 1, 0, 1 / (float)side, p->t + face * n);
    }
}

/* Lists of an occluder added up in p->coefs (clean before), the squares that they use and all above marked: square k of
   all levels in turn lies in square (k - 1) / 4. sfield__unlist cleans up. */
static void sfield__list(sfield__point *p, const sfield_field *f, const sfield__lists *lists, float factor)
{
    uint32_t i, bits = 0;
    while (1u << bits < p->s->side * p->s->side) bits++;
    for (i = 0; i < lists->count; i++) {
        const float weight = lists->weight[i] * factor * f->sample_scale[lists->sample[i]];
        const uint32_t *e = f->entry + f->offset[lists->sample[i]], *end = f->entry + f->offset[lists->sample[i] + 1];
        for (; e < end; e++) {
            const uint32_t index = *e >> 16, in_face = index & ((1u << bits) - 1);
            uint8_t *marks = p->marks + (index >> bits) * SFIELD__MARKS;
            uint32_t square = (in_face - 1) / 3;
            p->coefs[index] += weight * sfield__half(*e);
            if (!in_face) continue;
            for (; !marks[square]; square = (square - 1) / 4) {
                marks[square] = 1;
                if (!square) break;
            }
        }
    }
}

static void sfield__unlist(sfield__point *p)
{
    const uint32_t used = sfield__mark_base(p->s->side * p->s->side);
    uint32_t face;
    memset(p->coefs, 0, p->s->cells * sizeof *p->coefs);
    for (face = 0; face < 6; face++) memset(p->marks + face * SFIELD__MARKS, 0, used);
}

/* T times the visibility in p->coefs: expanded only where it has detail; rotated entities texel by texel. */
static void sfield__hide(sfield__point *p, uint32_t map)
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

static void sfield__lists_at(const sfield__item *it, int which, const float *x, float time, int simd,
                             sfield__lists *lists)
{
    const sfield_field *f = which ? it->e.source : it->e.occlusion;
    float p[48] = { 0 }, local[48];
    sfield__place at;
    uint32_t k;
    for (k = 0; k < 3; k++) p[16 * k] = x[k];
    sfield__to_local(it, which, p, local, simd);
    sfield__locate16(f, local, &at, simd);
    sfield__find_lists(f, &at, 0, time, lists);
}

/* Entities from near to far: occluders in reach and above the horizon, lights. 0 where the point is not to
   be shaded. */
static uint32_t sfield__rays(sfield__point *p, const float *x, const float *n)
{
    const sfield_scene *s = p->s;
    uint32_t i, j, count = 0, lights = 0;
    for (i = 0; i < s->item_count; i++) {
        const sfield__item *it = &s->item[i];
        int which;
        for (which = 1; which >= 0; which--) {
            const float *c = it->center[which];
            float d[3], d2;
            int light = which ? (int)lights : -1;
            if (which ? !it->e.source : !it->e.occlusion) continue;
            lights += (uint32_t)which;
            if (i == p->set->entity) continue;          /* neither hides nor lights its own points */
            d[0] = c[0] - x[0];
            d[1] = c[1] - x[1];
            d[2] = c[2] - x[2];
            d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            if (!which) {
                p->stats.pairs++;
                if (!(d2 < it->reach * it->reach)) {
                    p->stats.culled_far++;
                    continue;
                }
                if (d[0] * n[0] + d[1] * n[1] + d[2] * n[2] <= -it->radius[0]) {
                    p->stats.culled_horizon++;
                    continue;
                }
            }
            for (j = count++; j > 0 && p->ray[j - 1].d2 > d2; j--) p->ray[j] = p->ray[j - 1];
            p->ray[j].d2 = d2;
            p->ray[j].item = i;
            p->ray[j].light = light;
        }
    }
    return count;
}

/* Second rule, as for tiles: rays [0, i) are nearer. */
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
        if (p->ray[j].light >= 0 || !(b->inscribed > 0) || b->inscribed * b->inscribed >= e2 || b == a) continue;
        if (e2 > 0.5625f * b->reach * b->reach) continue;
        sin_b = b->inscribed / sqrtf(e2);
        if (sin_b <= sin_a) continue;
        for (k = 0; k < 3; k++) dot += (a->center[which][k] - x[k]) * (b->center[0][k] - x[k]);
        if (dot >= (cos_a * sqrtf(1 - sin_b * sin_b) + sin_a * sin_b) * sqrtf(d2 * e2)) return 1;
    }
    return 0;
}

#if SFIELD__SIMD
SFIELD__TARGET_AVX2 static void sfield__cosines_avx2(const float *texel, uint32_t cells, const float *n, float *t)
{
    const __m256 a = _mm256_set1_ps(n[0]), b = _mm256_set1_ps(n[1]), c = _mm256_set1_ps(n[2]);
    uint32_t i;
    for (i = 0; i < cells; i += 8, texel += 8) {
        __m256 d = _mm256_mul_ps(a, _mm256_loadu_ps(texel));
        d = _mm256_add_ps(d, _mm256_mul_ps(b, _mm256_loadu_ps(texel + cells)));
        d = _mm256_add_ps(d, _mm256_mul_ps(c, _mm256_loadu_ps(texel + 2 * (size_t)cells)));
        d = _mm256_max_ps(d, _mm256_setzero_ps());
        _mm256_storeu_ps(t + i, _mm256_mul_ps(d, _mm256_loadu_ps(texel + 3 * (size_t)cells)));
    }
}

/* sum[k] += dot products over every eighth texel, of three planes. */
SFIELD__TARGET_AVX2 static void sfield__dots_avx2(const float *sky, const float *t, uint32_t cells, float *sum)
{
    __m256 a = _mm256_setzero_ps(), b = a, c = a;
    uint32_t i;
    for (i = 0; i < cells; i += 8, sky += 8) {
        __m256 x = _mm256_loadu_ps(t + i);
        a = _mm256_fmadd_ps(x, _mm256_loadu_ps(sky), a);
        b = _mm256_fmadd_ps(x, _mm256_loadu_ps(sky + cells), b);
        c = _mm256_fmadd_ps(x, _mm256_loadu_ps(sky + 2 * (size_t)cells), c);
    }
    _mm256_storeu_ps(sum, a);
    _mm256_storeu_ps(sum + 8, b);
    _mm256_storeu_ps(sum + 16, c);
}
#endif

static void sfield__cosines(const sfield_scene *s, const float *n, float *t)
{
    const float *x = s->texel, *y = x + s->cells, *z = y + s->cells, *w = z + s->cells;
    uint32_t i;
#if SFIELD__SIMD
    if (s->simd) {
        sfield__cosines_avx2(s->texel, s->cells, n, t);
        return;
    }
#endif
    for (i = 0; i < s->cells; i++) {
        float c = n[0] * x[i] + n[1] * y[i] + n[2] * z[i];
        t[i] = (c > 0 ? c : 0.0f) * w[i];
    }
}

/* T = max(0, cos) x solid angle x visibility of the own object, on texels. */
static void sfield__start_texels(sfield__point *p, size_t index, const float *n)
{
    const sfield_scene *s = p->s;
    sfield__cosines(s, n, p->t);
    if (p->set->self) {
        sfield__lists own;
        const int sparse = s->desc.product == SFIELD_PRODUCT_SPARSE;
        uint32_t map = p->set->entity != SFIELD_NONE ? s->item[p->set->entity].map : 0;
        own.count = 1;
        own.sample[0] = index;
        own.weight[0] = 1;
        if (sparse) (void)sfield_haar_forward(s->side, p->t, p->haar);
        sfield__list(p, p->set->self, &own, 1);
        sfield__hide(p, map);
        sfield__unlist(p);
    } else if (s->desc.product == SFIELD_PRODUCT_SPARSE) (void)sfield_haar_forward(s->side, p->t, p->haar);
}

/* What a light's lists make of T in wavelets (rotated lights: of T on texels). */
static void sfield__light_up(sfield__point *p, const sfield__item *it, const float *x, const float *haar)
{
    const sfield_scene *s = p->s;
    const sfield_field *f = it->e.source;
    const uint32_t cells = s->cells;
    sfield__lists lists;
    float rgb[3] = { 0, 0, 0 };
    uint32_t i, k, c;
    sfield__lists_at(it, 1, x, it->e.time, s->simd, &lists);
    if (!it->map) {
        for (i = 0; i < lists.count; i++) {
            float w = lists.weight[i] * f->sample_scale[lists.sample[i]];
            for (k = f->offset[lists.sample[i]]; k < f->offset[lists.sample[i] + 1]; k++) {
                const uint32_t *e = f->entry + 2 * (size_t)k;
                float t = w * haar[e[0] >> 16];
                rgb[0] += t * sfield__half(e[0]);
                rgb[1] += t * sfield__half(e[1] >> 16);
                rgb[2] += t * sfield__half(e[1]);
            }
        }
    } else {
        const sfield__taps *taps = s->taps + (size_t)(it->map - 1) * cells;
        for (i = 0; i < lists.count; i++) sfield__scatter(f, lists.sample[i], lists.weight[i], p->coefs);
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

/* The largest wavelets of T into the cache, by the measure that fields are cut with. */
static void sfield__keep_wavelets(sfield__point *p, sfield_cache *c, size_t slot)
{
    const uint32_t cells = p->s->cells, side = p->s->side;
    uint16_t *index = c->index + slot * SFIELD__CACHED;
    int16_t *value = c->value + slot * SFIELD__CACHED;
    float threshold = 0, most = 0, inverse, weight = 0;
    uint32_t i, n = 0, used = 0, next = 0, face = side * side;
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
    if (used > SFIELD__CACHED) threshold = sfield__select(sorted, used, SFIELD__CACHED - 1);
    memset(sorted, 0, used * sizeof *sorted);
    for (i = 0; i < cells && n < SFIELD__CACHED; i++)
        if (key[i] > 0 && key[i] >= threshold) {
            index[n++] = (uint16_t)i;
            most = fabsf(p->haar[i]) > most ? fabsf(p->haar[i]) : most;
        }
    c->scale[slot] = most / 32767;
    inverse = most > SFIELD__LEAST_T ? 32767 / most : 0;
    for (i = 0; i < SFIELD__CACHED; i++) {
        float q = i < n ? p->haar[index[i]] * inverse : 0;
        value[i] = (int16_t)(q + (q < 0 ? -0.5f : 0.5f));
        if (i >= n) index[i] = 0;
    }
}

/* Light from the cache: few wavelets of T against the sky's, once for each T and sky, or unpacked for lists of
   lights. */
static void sfield__from_cache(sfield__point *p, const sfield_cache *c, size_t slot, const sfield__item *it,
                               const float *x)
{
    const uint16_t *index = c->index + slot * SFIELD__CACHED;
    const int16_t *value = c->value + slot * SFIELD__CACHED;
    const uint32_t cells = p->s->cells;
    uint32_t i, k;
    if (!it) {
        const uint64_t now = sfield__hash(c->hash[slot], p->s->sky_version) | 1;
        uint64_t *lit = &c->lit[slot / c->lights];
        float *rgb = c->sky + 3 * (slot / c->lights);
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
        sfield__light_up(p, it, x, NULL);
        return;
    }
    for (i = 0; i < SFIELD__CACHED; i++) p->coefs[index[i]] += (float)value[i] * c->scale[slot];
    sfield__light_up(p, it, x, p->coefs);
    for (i = 0; i < SFIELD__CACHED; i++) p->coefs[index[i]] = 0;
}

static void sfield__sky_up(sfield__point *p)
{
    const sfield_scene *s = p->s;
    const int sparse = s->desc.product == SFIELD_PRODUCT_SPARSE;
    const float *sky = s->sky_now + (sparse ? 3u : 0u) * s->cells, *t = sparse ? p->haar : p->t;
    float sum[24] = { 0 };
    uint32_t c, i, k;
#if SFIELD__SIMD
    if (s->simd) sfield__dots_avx2(sky, t, s->cells, sum);
    else
#endif
        for (c = 0; c < 3; c++)
            for (i = 0; i < s->cells; i += 8)
                for (k = 0; k < 8; k++) sum[8 * c + k] += sky[c * s->cells + i + k] * t[i + k];
    for (c = 0; c < 3; c++)
        for (k = 0; k < 8; k++) p->rgb[c] += sum[8 * c + k];
}

/* Figure 5 on texels (or on coefficients). With a cache it is only filled: those lights are added from what
   was kept. */
static void sfield__walk(sfield__point *p, size_t index, const float *x, const float *n, uint32_t count,
                         sfield_cache *cache, const uint64_t *hash, float *ambient)
{
    const sfield_scene *s = p->s;
    const int sparse = s->desc.product == SFIELD_PRODUCT_SPARSE;
    uint32_t i, k;
    int fresh = 0;                              /* p->haar is that of p->t */
    sfield__start_texels(p, index, n);
    for (i = 0; i <= count; i++) {
        const sfield__item *it = i < count ? &s->item[p->ray[i].item] : NULL;
        uint32_t slot = it ? (uint32_t)p->ray[i].light : s->light_count;
        int keep;
        if (it && p->ray[i].light < 0) {
            sfield__lists lists;
            float fade = 4 * (1 - sqrtf(p->ray[i].d2) / it->reach);
            if (sfield__is_hidden(p, i, x)) {
                p->stats.culled_hidden++;
                continue;
            }
            sfield__lists_at(it, 0, x, 0, s->simd, &lists);
            sfield__list(p, it->e.occlusion, &lists, fade < 1 ? fade : 1);
            sfield__hide(p, it->map);
            sfield__unlist(p);
            p->stats.products++;
            fresh = 0;
            continue;
        }
        keep = cache && slot < cache->lights;
        if (!fresh && !sparse && (keep || (it && !it->map))) {
            (void)sfield_haar_forward(s->side, p->t, p->haar);
            fresh = 1;
        }
        if (keep) {
            size_t at = index * cache->lights + slot;
            if (cache->hash[at] != hash[slot]) sfield__keep_wavelets(p, cache, at);
            cache->hash[at] = hash[slot];
        } else if (it) sfield__light_up(p, it, x, p->haar);
        else if (s->has_sky || s->has_sun) sfield__sky_up(p);
    }
    if (ambient) {
        float sum = 0;
        if (sparse) sfield__haar_texels(s->side, p->haar, p->t);
        for (k = 0; k < s->cells; k++) sum += p->t[k];
        *ambient = sum * 0.318309886f;
    }
}

static void sfield__shade_point(sfield__point *p, size_t index, uint64_t *hash)
{
    const sfield_scene *s = p->s;
    const sfield_points *set = p->set;
    sfield_cache *cache = set->cache;
    sfield__tile one;                           /* for its way of loading */
    float x[3], n[3], ambient = 0, rgb[3] = { 0, 0, 0 };
    uint32_t count, i, j, k, slots = s->light_count + 1, stale = !cache || cache->lights < slots;
    const uint32_t lights = sfield__lights_of(s, set, s->has_sky || s->has_sun);
    memset(&one, 0, sizeof one);
    one.s = s;
    one.set = set;
    one.first = index;
    one.lanes = 1;
    sfield__load(&one);
    p->rgb = rgb;
    if (one.visible) {
        for (k = 0; k < 3; k++) {
            x[k] = one.p[16 * k];
            n[k] = one.n[16 * k];
        }
        p->stats.points++;
        p->stats.lights += lights;
        count = sfield__rays(p, x, n);
        for (j = 0; j < slots; j++) hash[j] = 0;
        for (i = 0; i <= count; i++) {          /* the occluders before each light */
            uint64_t h = p->stand;
            uint32_t slot = i < count ? (uint32_t)p->ray[i].light : slots - 1;
            if (i < count && p->ray[i].light < 0) continue;
            for (k = 0; k < i; k++)
                if (p->ray[k].light < 0) h = sfield__hash(h, p->ray[k].item);
            hash[slot] = h | 1;
            if (cache && slot < cache->lights && cache->hash[index * cache->lights + slot] != hash[slot]) stale = 1;
        }
        if (stale) sfield__walk(p, index, x, n, count, cache, hash, set->ambient ? &ambient : NULL);
        else p->stats.reused += lights;
        for (j = 0; cache && j < slots && j < cache->lights; j++)
            if (!hash[j]) continue;             /* the own entity's */
            else if (j < s->light_count)
                sfield__from_cache(p, cache, index * cache->lights + j, &s->item[s->light[j]], x);
            else if (s->has_sky || s->has_sun) sfield__from_cache(p, cache, index * cache->lights + j, NULL, x);
        if (set->ambient && !stale) {
            size_t at = (index * cache->lights + slots - 1) * SFIELD__CACHED;
            for (i = 0; i < SFIELD__CACHED; i++)
                if (cache->index[at + i] % (s->side * s->side) == 0)
                    ambient +=
                        (float)cache->value[at + i] * cache->scale[at / SFIELD__CACHED] * (float)s->side * 0.318309886f;
        }
    }
    p->rgb = NULL;
    for (k = 0; k < 3 && set->rgb; k++) set->rgb[3 * index + k] = rgb[k] * 0.318309886f;
    if (set->ambient) set->ambient[index] = ambient;
}

/* ---- >>bundles: sixteen points in wavelets ---- */

/* Neighbours whose entities have one order from near to far are shaded together, a lane each, face by face: texels,
   wavelets and sums are planes of sixteen, so that directions, sky and the samples that several points lie between are
   read once for all of them. */
enum { SFIELD__STRANDS = 32, SFIELD__STRAND_LISTS = 256, SFIELD__BLOCK = 64, SFIELD__FEWEST = 3 };

typedef struct sfield__listing {    /* what is kept at a sample, and how much of it each point takes */
    const uint32_t *e, *end;
    size_t sample;
    float weight[SFIELD__LANES];
} sfield__listing;

typedef struct sfield__strand {     /* an entity in the order */
    uint32_t item, lanes, count;
    int      light;                 /* its number, -1 an occluder, -2 the own visibility */
    float    d2[SFIELD__LANES];
    sfield__listing *list;          /* room for SFIELD__STRAND_LISTS: 16 points between 8 samples of 2 frames */
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

/* The text for each kind of vectors. */
#define SFIELD__BUNDLES(V, TARGET)                                                                                     \
    /* T = max(0, cos) x solid angle. 0: it is 0 everywhere. */                                                        \
    TARGET static int sfield__begin_##V(sfield__bundle *b, const float *texel, uint32_t n)                             \
    {                                                                                                                  \
        const sfield__##V x = sfield__##V##_load(b->n), y = sfield__##V##_load(b->n + 16);                             \
        const sfield__##V z = sfield__##V##_load(b->n + 32);                                                           \
        const size_t cells = b->s->cells;                                                                              \
        const uint32_t block = n < SFIELD__BLOCK ? n : (uint32_t)SFIELD__BLOCK;                                        \
        uint32_t i, k, any = 0;                                                                                        \
        for (i = 0; i < n; i += block) {                                                                               \
            static const uint8_t corner[4] = { 0, 21, 42, 63 };                                                        \
            sfield__##V sum = sfield__##V##_set1(0);                                                                   \
            for (k = 0; k < 4 && block == SFIELD__BLOCK; k++) {                                                        \
                const float *q = texel + i + corner[k];                                                                \
                sfield__##V d = sfield__##V##_mul(x, sfield__##V##_set1(q[0]));                                        \
                d = sfield__##V##_fma(y, sfield__##V##_set1(q[cells]), d);                                             \
                d = sfield__##V##_positive(sfield__##V##_fma(z, sfield__##V##_set1(q[2 * cells]), d));                 \
                sum = sfield__##V##_add(sum, d);                                                                       \
            }                                                                                                          \
            b->live[i / block] = (uint8_t)(block < SFIELD__BLOCK || sfield__##V##_any(sum));                           \
            any |= b->live[i / block];                                                                                 \
            if (!b->live[i / block]) continue;          /* all corners, so all of it, below the horizon of all */      \
            for (k = i; k < i + block; k++) {                                                                          \
                const float *q = texel + k;                                                                            \
                sfield__##V d = sfield__##V##_mul(x, sfield__##V##_set1(q[0]));                                        \
                d = sfield__##V##_fma(y, sfield__##V##_set1(q[cells]), d);                                             \
                d = sfield__##V##_positive(sfield__##V##_fma(z, sfield__##V##_set1(q[2 * cells]), d));                 \
                d = sfield__##V##_mul(d, sfield__##V##_set1(q[3 * cells]));                                            \
                sfield__##V##_store(b->t + 16 * (size_t)k, d);                                                         \
            }                                                                                                          \
        }                                                                                                              \
        return (int)any;                                                                                               \
    }                                                                                                                  \
    /* The part of a list in this face, into planes that are cleared square by square when they are first used. */     \
    TARGET static uint32_t sfield__gather_##V(sfield__bundle *b, sfield__listing *list, uint32_t last, uint32_t count, \
                                              float factor)                                                            \
    {                                                                                                                  \
        const sfield__##V zero = sfield__##V##_set1(0);                                                                \
        const sfield__##V weight = sfield__##V##_mul(sfield__##V##_set1(factor), sfield__##V##_load(list->weight));    \
        const uint32_t *e = list->e, *end = list->end, mask = b->s->side * b->s->side - 1;                             \
        float *planes = b->w;                                                                                          \
        uint8_t *marks = b->marks;                                                                                     \
        for (; e < end && *e < last; e++) {                                                                            \
            const uint32_t index = *e >> 16 & mask;                                                                    \
            uint32_t square = (index - 1) / 3;                                                                         \
            float *w = planes + 16 * (size_t)index;                                                                    \
            for (; index && !marks[square]; square = (square - 1) / 4) {                                               \
                float *first = planes + 16 * (size_t)(3 * square + 1);                                                 \
                marks[square] = 1;                                                                                     \
                b->used[count++] = (uint16_t)square;                                                                   \
                sfield__##V##_store(first, zero);                                                                      \
                sfield__##V##_store(first + 16, zero);                                                                 \
                sfield__##V##_store(first + 32, zero);                                                                 \
                if (!square) break;                                                                                    \
            }                                                                                                          \
            sfield__##V##_store(w, sfield__##V##_fma(sfield__##V##_set1(sfield__half(*e)), weight,                     \
                                                     sfield__##V##_load(w)));                                          \
        }                                                                                                              \
        list->e = e;                                                                                                   \
        return count;                                                                                                  \
    }                                                                                                                  \
    TARGET static void sfield__dim_##V(const sfield__bundle *b, uint32_t i, uint32_t n, sfield__##V mean)              \
    {                                                                                                                  \
        const sfield__##V keep = sfield__##V##_sub(sfield__##V##_set1(1), mean);                                       \
        uint32_t k;                                                                                                    \
        float *t;                                                                                                      \
        for (k = i * n; k < (i + 1) * n; k++) {                                                                        \
            if (n >= SFIELD__BLOCK && k % SFIELD__BLOCK == 0 && !b->live[k / SFIELD__BLOCK]) {                         \
                k += SFIELD__BLOCK - 1;                                                                                \
                continue;                                                                                              \
            }                                                                                                          \
            t = b->t + 16 * (size_t)k;                                                                                 \
            sfield__##V##_store(t, sfield__##V##_mul(sfield__##V##_load(t), keep));                                    \
        }                                                                                                              \
    }                                                                                                                  \
    /* As sfield__shade_square, of a square that is marked. */                                                         \
    TARGET static void sfield__darken_##V(const sfield__bundle *b, uint32_t leaves, const sfield__##V *mean,           \
                                          uint32_t squares, uint32_t i, float scale)                                   \
    {                                                                                                                  \
        const sfield__##V s = sfield__##V##_set1(scale), one = sfield__##V##_set1(1);                                  \
        const float *w = b->w + 16 * (size_t)(squares + 3 * i);                                                        \
        const sfield__##V x = sfield__##V##_mul(s, sfield__##V##_load(w));                                             \
        const sfield__##V y = sfield__##V##_mul(s, sfield__##V##_load(w + 16));                                        \
        const sfield__##V z = sfield__##V##_mul(s, sfield__##V##_load(w + 32));                                        \
        const sfield__##V a = sfield__##V##_add(*mean, y), d = sfield__##V##_sub(*mean, y);                            \
        const sfield__##V f = sfield__##V##_add(x, z), g = sfield__##V##_sub(x, z);                                    \
        const uint32_t n = leaves / squares, below = (4 * squares - 1) / 3 + 4 * i;                                    \
        sfield__##V m[4];                                                                                              \
        uint32_t k;                                                                                                    \
        if (4 * n == SFIELD__BLOCK && !b->live[i]) return;                                                             \
        m[0] = sfield__##V##_add(a, f);                                                                                \
        m[1] = sfield__##V##_sub(a, f);                                                                                \
        m[2] = sfield__##V##_add(d, g);                                                                                \
        m[3] = sfield__##V##_sub(d, g);                                                                                \
        for (k = 0; k < 4; k++) {                                                                                      \
            float *t = b->t + 16 * (size_t)(4 * i + k);                                                                \
            if (n == 1)                                                                                                \
                sfield__##V##_store(t, sfield__##V##_mul(sfield__##V##_load(t), sfield__##V##_sub(one, m[k])));        \
            else if (b->marks[below + k]) sfield__darken_##V(b, leaves, &m[k], 4 * squares, 4 * i + k, 2 * scale);     \
            else if (sfield__##V##_any(m[k])) sfield__dim_##V(b, 4 * i + k, n, m[k]);                                  \
        }                                                                                                              \
    }                                                                                                                  \
    /* T times the visibility of an occluder. 0: it has nothing in this face. */                                       \
    TARGET static int sfield__hide_##V(sfield__bundle *b, sfield__strand *strand, const sfield_field *f, uint32_t last,\
                                       uint32_t leaves)                                                                \
    {                                                                                                                  \
        const float scale = 1 / (float)b->s->side;                                                                     \
        uint32_t i, count = 0;                                                                                         \
        sfield__##V mean;                                                                                              \
        for (i = 0; i < strand->count && !(strand->list[i].e < strand->list[i].end && *strand->list[i].e < last);) i++;\
        if (i == strand->count) return 0;                                                                              \
        sfield__##V##_store(b->w, sfield__##V##_set1(0));                                                              \
        for (i = 0; i < strand->count; i++)                                                                            \
            count = sfield__gather_##V(b, &strand->list[i], last, count, f->sample_scale[strand->list[i].sample]);     \
        mean = sfield__##V##_mul(sfield__##V##_load(b->w), sfield__##V##_set1(scale));                                 \
        if (b->marks[0]) sfield__darken_##V(b, leaves, &mean, 1, 0, scale);                                            \
        else sfield__dim_##V(b, 0, 4 * leaves, mean);                                                                  \
        for (i = 0; i < count; i++) b->marks[b->used[i]] = 0;                                                          \
        return 1;                                                                                                      \
    }                                                                                                                  \
    /* Squares of a level: wavelets to out, scaling coefficients to up. */                                             \
    TARGET static void sfield__level_##V(const float *c, uint32_t squares, float *up, float *out)                      \
    {                                                                                                                  \
        const sfield__##V half = sfield__##V##_set1(0.5f);                                                             \
        for (; squares > 0; squares--, c += 64, up += 16, out += 48) {                                                 \
            const sfield__##V p = sfield__##V##_load(c), q = sfield__##V##_load(c + 16);                               \
            const sfield__##V r = sfield__##V##_load(c + 32), s = sfield__##V##_load(c + 48);                          \
            const sfield__##V a = sfield__##V##_add(p, q), b = sfield__##V##_sub(p, q);                                \
            const sfield__##V d = sfield__##V##_add(r, s), e = sfield__##V##_sub(r, s);                                \
            sfield__##V##_store(out, sfield__##V##_mul(half, sfield__##V##_add(b, e)));                                \
            sfield__##V##_store(out + 16, sfield__##V##_mul(half, sfield__##V##_sub(a, d)));                           \
            sfield__##V##_store(out + 32, sfield__##V##_mul(half, sfield__##V##_sub(b, e)));                           \
            sfield__##V##_store(up, sfield__##V##_mul(half, sfield__##V##_add(a, d)));                                 \
        }                                                                                                              \
    }                                                                                                                  \
    /* Wavelets of the face, up to 64 texels at a time in what is nearest to the processor. */                         \
    TARGET static void sfield__transform_##V(sfield__bundle *b, uint32_t n)                                            \
    {                                                                                                                  \
        const uint32_t block = n < SFIELD__BLOCK ? n : (uint32_t)SFIELD__BLOCK;                                        \
        float sums[16 * SFIELD__BLOCK], part[16 * 21];                                                                 \
        uint32_t i, squares;                                                                                           \
        for (i = 0; i < n / block; i++) {                                                                              \
            const float *from = b->t + 16 * (size_t)(i * block);                                                       \
            float *up = part;                                                                                          \
            for (squares = block / 4; squares; squares /= 4) {                                                         \
                const size_t all = (size_t)squares * (n / block), at = all + 3 * (size_t)squares * i;                  \
                if (b->live[i])                                                                                        \
                    sfield__level_##V(from, squares, squares == 1 ? sums + 16 * i : up, b->w + 16 * at);               \
                else memset(b->w + 16 * at, 0, 48 * (size_t)squares * sizeof *b->w);                                   \
                from = up;                                                                                             \
                up += 16 * squares;                                                                                    \
            }                                                                                                          \
            if (!b->live[i]) memset(sums + 16 * i, 0, 16 * sizeof *sums);                                              \
        }                                                                                                              \
        for (squares = n / block / 4; squares; squares /= 4)      /* a sum falls on one that is done */                \
            sfield__level_##V(sums, squares, sums, b->w + 16 * (size_t)squares);                                       \
        memcpy(b->w, sums, 16 * sizeof *sums);                                                                         \
    }                                                                                                                  \
    TARGET static void sfield__lit_##V(sfield__bundle *b, sfield__strand *strand, const sfield_field *f,             \
                                         uint32_t last, uint32_t n, int *fresh)                                        \
    {                                                                                                                  \
        const float *tint = b->s->item[strand->item].e.tint;                                                           \
        sfield__##V sum[3];                                                                                            \
        uint32_t i, c;                                                                                                 \
        for (c = 0; c < 3; c++) sum[c] = sfield__##V##_set1(0);                                                        \
        for (i = 0; i < strand->count; i++) {                                                                          \
            sfield__listing *l = &strand->list[i];                                                                     \
            const sfield__##V weight = sfield__##V##_mul(sfield__##V##_set1(f->sample_scale[l->sample]),               \
                                                         sfield__##V##_load(l->weight));                               \
            for (; l->e < l->end && l->e[0] < last; l->e += 2) {                                                       \
                sfield__##V t;                                                                                         \
                if (!*fresh) sfield__transform_##V(b, n);                                                              \
                *fresh = 1;                                                                                            \
                t = sfield__##V##_mul(weight, sfield__##V##_load(b->w + 16 * (size_t)(l->e[0] >> 16 & (n - 1))));      \
                sum[0] = sfield__##V##_fma(t, sfield__##V##_set1(sfield__half(l->e[0])), sum[0]);                      \
                sum[1] = sfield__##V##_fma(t, sfield__##V##_set1(sfield__half(l->e[1] >> 16)), sum[1]);                \
                sum[2] = sfield__##V##_fma(t, sfield__##V##_set1(sfield__half(l->e[1])), sum[2]);                      \
            }                                                                                                          \
        }                                                                                                              \
        for (c = 0; c < 3; c++) {                                                                                      \
            float *to = b->rgb + 16 * c;                                                                               \
            sfield__##V##_store(to, sfield__##V##_fma(sfield__##V##_set1(tint[c]), sum[c], sfield__##V##_load(to)));   \
        }                                                                                                              \
    }                                                                                                                  \
    /* What is left of the sky, and of a white one. */                                                                 \
    TARGET static void sfield__end_##V(sfield__bundle *b, const float *sky, uint32_t n)                                \
    {                                                                                                                  \
        const size_t cells = b->s->cells;                                                                              \
        const uint32_t block = n < SFIELD__BLOCK ? n : (uint32_t)SFIELD__BLOCK;                                        \
        const int ambient = b->ambient;                                                                                \
        sfield__##V x = sfield__##V##_set1(0), y = x, z = x, sum = x;                                                  \
        uint32_t i, k;                                                                                                 \
        for (i = 0; i < n; i += block) {                                                                               \
            const float *q = sky + i, *from = b->t + 16 * (size_t)i;                                                   \
            if (!b->live[i / block]) continue;                                                                         \
            for (k = 0; k < block; k++) {                                                                              \
                const sfield__##V t = sfield__##V##_load(from + 16 * (size_t)k);                                       \
                x = sfield__##V##_fma(t, sfield__##V##_set1(q[k]), x);                                                 \
                y = sfield__##V##_fma(t, sfield__##V##_set1(q[cells + k]), y);                                         \
                z = sfield__##V##_fma(t, sfield__##V##_set1(q[2 * cells + k]), z);                                     \
            }                                                                                                          \
            for (k = 0; k < block && ambient; k++)                                                                     \
                sum = sfield__##V##_add(sum, sfield__##V##_load(from + 16 * (size_t)k));                               \
        }                                                                                                              \
        if (b->s->has_sky || b->s->has_sun) {                                                                          \
            sfield__##V##_store(b->rgb, sfield__##V##_add(x, sfield__##V##_load(b->rgb)));                             \
            sfield__##V##_store(b->rgb + 16, sfield__##V##_add(y, sfield__##V##_load(b->rgb + 16)));                   \
            sfield__##V##_store(b->rgb + 32, sfield__##V##_add(z, sfield__##V##_load(b->rgb + 32)));                   \
        }                                                                                                              \
        sfield__##V##_store(b->open, sfield__##V##_add(sum, sfield__##V##_load(b->open)));                             \
    }                                                                                                                  \
    TARGET static void sfield__face_##V(sfield__bundle *b, const sfield_field *self, uint32_t face)                    \
    {                                                                                                                  \
        const sfield_scene *s = b->s;                                                                                  \
        const uint32_t n = s->side * s->side, first = face * n << 16, last = (face + 1) * n << 16;                     \
        uint32_t i, k;                                                                                                 \
        int fresh = 0;                          /* b->w are the wavelets of b->t */                                    \
        if (!sfield__begin_##V(b, s->texel + face * n, n)) return;                                                     \
        for (i = 0; i < b->strands; i++) {                                                                             \
            sfield__strand *strand = &b->strand[i];                                                                    \
            const sfield_entity *e = strand->light < -1 ? NULL : &s->item[strand->item].e;                             \
            const sfield_field *f = !e ? self : strand->light < 0 ? e->occlusion : e->source;                          \
            for (k = 0; k < strand->count; k++)                                                                        \
                while (strand->list[k].e < strand->list[k].end && *strand->list[k].e < first)                          \
                    strand->list[k].e += f->h.stride;                                                                  \
            if (strand->light >= 0) sfield__lit_##V(b, strand, f, last, n, &fresh);                                  \
            else if (sfield__hide_##V(b, strand, f, last, n / 4)) fresh = 0;                                           \
        }                                                                                                              \
        sfield__end_##V(b, s->sky_now + face * n, n);                                                                  \
    }

SFIELD__BUNDLES(plain, )
#if SFIELD__SIMD
SFIELD__BUNDLES(avx2, SFIELD__TARGET_AVX2)
SFIELD__BUNDLES(avx512, SFIELD__TARGET_AVX512)
#endif
#undef SFIELD__BUNDLES

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
    return (2 * plane * sizeof(float) + 2 * strands * sizeof(sfield__strand) + lists * sizeof(sfield__listing) +
            3 * SFIELD__MARKS + 63) / 64 * 64;
}

/* The rays of a point among those of the bundle, from near to far. 0: they have another order, or are too many. */
static int sfield__weave(sfield__bundle *b, const sfield__point *p, uint32_t rays, const float *x, uint32_t lane,
                         uint64_t *hidden)
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

/* What is kept at a sample, for one more lane. */
static void sfield__take_list(sfield__strand *strand, const sfield_field *f, size_t sample, uint32_t lane, float weight)
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

/* The samples around the lanes' places; of occluders they fade over the last quarter of their reach. */
static void sfield__take_lists(sfield__strand *strand, const sfield__item *it, const sfield__tile *tile, int simd)
{
    const int which = strand->light >= 0;
    const sfield_field *f = which ? it->e.source : it->e.occlusion;
    float local[48];
    sfield__place at;
    sfield__lists lists;
    uint32_t l, k;
    strand->count = 0;
    sfield__to_local(it, which, tile->p, local, simd);
    sfield__locate16(f, local, &at, simd);
    for (l = 0; l < SFIELD__LANES; l++) {
        float factor = 1;
        if (!(strand->lanes >> l & 1)) continue;
        sfield__find_lists(f, &at, (int)l, which ? it->e.time : 0.0f, &lists);
        if (!which) factor = 4 * (1 - sqrtf(strand->d2[l]) / it->reach);
        factor = factor < 1 ? factor : 1.0f;
        for (k = 0; k < lists.count; k++) sfield__take_list(strand, f, lists.sample[k], l, lists.weight[k] * factor);
    }
}

/* The woven lanes of a tile: each by its own entities, all face by face. */
static void sfield__run_bundle(sfield__bundle *b, const sfield_points *set, const sfield__tile *tile, uint32_t lanes)
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
    for (face = 0; face < 6; face++) {
#if SFIELD__SIMD
        if (s->simd == 2) sfield__face_avx512(b, set->self, face);
        else if (s->simd == 1) sfield__face_avx2(b, set->self, face);
        else
#endif
            sfield__face_plain(b, set->self, face);
    }
    for (l = 0; l < SFIELD__LANES; l++) {
        const size_t at = tile->first + l;
        if (!(lanes >> l & 1)) continue;
        for (i = 0; i < 3 && set->rgb; i++) set->rgb[3 * at + i] = b->rgb[16 * i + l] * 0.318309886f;
        if (set->ambient) set->ambient[at] = b->open[l] * 0.318309886f;
    }
}

/* As many lanes as have one order of their entities; few of them go by themselves. */
static void sfield__shade_bundle(sfield__point *p, sfield__bundle *b, size_t first, uint32_t lanes, uint64_t *hash)
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
    sfield__load(&tile);
    while (left) {
        const sfield_scene_stats before = p->stats;
        uint32_t taken = 0, count = 0;
        b->strands = 0;
        for (l = 0; l < lanes; l++) {
            const sfield_scene_stats then = p->stats;
            uint64_t hidden = 0;
            float x[3], n[3];
            if (!(left & tile.visible & 1u << l)) continue;
            for (k = 0; k < 3; k++) {
                x[k] = tile.p[16 * k + l];
                n[k] = tile.n[16 * k + l];
            }
            if (sfield__weave(b, p, sfield__rays(p, x, n), x, l, &hidden)) {
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
                for (l = 0; b->strand[i].light < 0 && l < lanes; l++) p->stats.products += b->strand[i].lanes >> l & 1;
            sfield__run_bundle(b, set, &tile, taken);
        }
        left &= ~taken;
    }
}

/* Whether bundles can: texels, nothing kept, nobody turned who hides, shines or brings an own visibility. */
static int sfield__bundles(const sfield_scene *s, const sfield_points *set)
{
    uint32_t i;
    if (set->cache || s->desc.product == SFIELD_PRODUCT_SPARSE) return 0;
    if (set->self && set->entity != SFIELD_NONE && s->item[set->entity].map) return 0;
    for (i = 0; i < s->item_count; i++)
        if (s->item[i].map && (s->item[i].e.occlusion || s->item[i].e.source)) return 0;
    return 1;
}

/* ---- >>shade ---- */

typedef struct sfield__job {
    sfield_scene        *s;
    const sfield_points *sets;
    size_t               set_count;
    size_t               scratch;               /* bytes a task */
    uint32_t             pieces;
    float               *incident;
    sfield_scene_stats   stats[SFIELD__PIECES];
} sfield__job;

static void sfield__shade_set_sh(const sfield__job *job, const sfield_points *set, size_t piece, uint8_t *memory,
                                 sfield_scene_stats *stats)
{
    const sfield_scene *s = job->s;
    sfield__tile t;
    size_t i;
    memset(&t, 0, sizeof t);
    t.s = s;
    t.set = set;
    t.lights = s->light_count;
    t.sky = s->has_sky || s->has_sun || set->ambient;
    t.chains = set->gloss && set->exponents ? 2 : 1;
    t.all_round = job->incident != NULL;
    t.stand = sfield__stand(s, set);
    t.stats = *stats;
    (void)sfield__carve(&t, memory, s->occluder_count, t.lights, s->coefs, (uint32_t)t.chains);
    for (i = piece * SFIELD__LANES; i < set->count; i += job->pieces * SFIELD__LANES) {
        t.first = i;
        t.lanes = set->count - i < SFIELD__LANES ? (uint32_t)(set->count - i) : (uint32_t)SFIELD__LANES;
        if (job->incident) sfield__incident_tile(&t, job->incident);
        else sfield__shade_tile(&t);
    }
    *stats = t.stats;
}

static void sfield__shade_set_haar(const sfield__job *job, const sfield_points *set, size_t piece, uint8_t *memory,
                                   sfield_scene_stats *stats)
{
    const sfield_scene *s = job->s;
    uint64_t *hash = (uint64_t *)(void *)memory;
    const uint32_t rays = s->occluder_count + s->light_count;
    const int bundles = sfield__bundles(s, set);
    sfield__point p;
    sfield__bundle b;
    size_t i, k;
    memset(&p, 0, sizeof p);
    memset(&b, 0, sizeof b);
    p.s = b.s = s;
    p.set = set;
    p.stand = sfield__stand(s, set);
    p.stats = *stats;
    memory += ((size_t)s->light_count + 8) / 8 * 64;
    memory += sfield__carve_point(&p, memory, rays, s->cells);
    (void)sfield__carve_bundle(&b, memory, rays, s->side);
    for (i = piece * SFIELD__LANES; i < set->count; i += job->pieces * SFIELD__LANES) {
        const size_t end = i + SFIELD__LANES < set->count ? i + SFIELD__LANES : set->count;
        if (bundles) sfield__shade_bundle(&p, &b, i, (uint32_t)(end - i), hash);
        for (k = i; k < end && !bundles; k++) sfield__shade_point(&p, k, hash);
    }
    *stats = p.stats;
}

static void sfield__shade_task(void *context, size_t piece)
{
    sfield__job *job = (sfield__job *)context;
    uint8_t *memory = job->s->scratch + piece * job->scratch;
    size_t i;
    memory += (64 - ((uintptr_t)memory & 63)) & 63;
    for (i = 0; i < job->set_count; i++)
        if (job->s->algebra) sfield__shade_set_sh(job, &job->sets[i], piece, memory, &job->stats[piece]);
        else sfield__shade_set_haar(job, &job->sets[i], piece, memory, &job->stats[piece]);
}

/* The entity of a set where it is rotated and only receives, so has no table for a resampling, and the set's own
   visibility, in wavelets, needs one; else NULL. */
static sfield__item *sfield__unmapped(const sfield_scene *s, const sfield_points *p)
{
    sfield__item *it = p->entity == SFIELD_NONE || !p->count || !p->self || s->algebra ? NULL : &s->item[p->entity];
    return it && !it->identity && !it->map ? it : NULL;
}

/* Tables for them, few and seldom, so that other receivers go without. */
static sfield_result sfield__map_receivers(sfield_scene *s, const sfield_points *sets, size_t count)
{
    const size_t cells = s->cells;
    sfield__taps *grown;
    uint32_t more = 0;
    size_t i;
    for (i = 0; i < count; i++) more += sfield__unmapped(s, &sets[i]) != NULL;
    if (!more) return SFIELD_OK;
    grown = (sfield__taps *)sfield__alloc_array(&s->allocator, ((size_t)s->maps + more) * cells, sizeof *grown);
    if (!grown) return SFIELD_ERR_ALLOC;
    if (s->maps) memcpy(grown, s->taps, s->maps * cells * sizeof *grown);
    sfield__free(&s->allocator, s->taps);
    s->taps = grown;
    for (i = 0; i < count; i++) {
        sfield__item *it = sfield__unmapped(s, &sets[i]);
        if (!it) continue;
        sfield__taps_make(s, it->turn, s->taps + s->maps * cells);
        it->map = ++s->maps;
    }
    return SFIELD_OK;
}

static sfield_result sfield__check_set(const sfield_scene *s, const sfield_points *p)
{
    if (p->count == 0) return SFIELD_OK;
    if (!p->positions || !p->normals || p->count > 0x7fffffffu) return SFIELD_ERR_ARGUMENT;
    if (!sfield__stride_valid(p->position_stride, 12) || !sfield__stride_valid(p->normal_stride, 12) ||
        (p->views && !sfield__stride_valid(p->view_stride, 12)) || p->view_stride % 4 || p->exponent_stride % 4)
        return SFIELD_ERR_ARGUMENT;
    if (p->entity != SFIELD_NONE && p->entity >= s->item_count) return SFIELD_ERR_ARGUMENT;
    if (p->gloss && p->exponents && !p->views) return SFIELD_ERR_ARGUMENT;
    if (p->gloss && !s->algebra) return SFIELD_ERR_BASIS;
    if (p->self && (!sfield__field_fits(s, p->self, SFIELD_KIND_SELF) || p->self->h.samples != p->count))
        return SFIELD_ERR_BASIS;
    if (s->desc.product == SFIELD_PRODUCT_SPARSE && sfield__unmapped(s, p)) return SFIELD_ERR_ROTATION;
    if (p->cache && (p->cache->points != p->count || p->cache->coefs != s->coefs || !p->cache->cells != !!s->algebra))
        return SFIELD_ERR_BASIS;
    return SFIELD_OK;
}

static sfield_result sfield__shade_all(sfield__job *job, sfield_scene_stats *stats)
{
    sfield_scene *s = job->s;
    const uint64_t *from;
    uint64_t *to;
    uint64_t bytes = 64;
    size_t i, k;
    if (s->algebra) {
        bytes += sfield__carve(NULL, NULL, s->occluder_count, s->light_count, s->coefs, 2);
    } else {
        bytes += sfield__carve_point(NULL, NULL, s->occluder_count + s->light_count, s->cells);
        bytes += sfield__carve_bundle(NULL, NULL, s->occluder_count + s->light_count, s->side);
        bytes += ((size_t)s->light_count + 8) / 8 * 64;
    }
    job->pieces = s->desc.parallel_for ? (uint32_t)SFIELD__PIECES : 1u;
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
    if (s->desc.parallel_for) s->desc.parallel_for(s->desc.parallel_user, job->pieces, sfield__shade_task, job);
    else sfield__shade_task(job, 0);
    if (!stats) return SFIELD_OK;
    memset(stats, 0, sizeof *stats);
    to = &stats->points;
    for (i = 0; i < job->pieces; i++)           /* eight counters of 64 bits, then the overlaps */
        for (k = 0, from = &job->stats[i].points; k < 8; k++) to[k] += from[k];
    stats->overlaps = s->overlaps;
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_shade(sfield_scene *scene, const sfield_points *sets, size_t set_count,
                                      sfield_scene_stats *stats)
{
    sfield__job job;
    size_t i;
    if (!scene || (!sets && set_count)) return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < set_count; i++) {
        sfield_result result = sfield__check_set(scene, &sets[i]);
        if (result != SFIELD_OK) return result;
    }
    if (sfield__map_receivers(scene, sets, set_count) != SFIELD_OK) return SFIELD_ERR_ALLOC;
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
    if (!scene || !set || !coefs) return SFIELD_ERR_ARGUMENT;
    result = sfield__check_set(scene, set);
    if (result != SFIELD_OK) return result;
    if (!scene->algebra || scene->desc.product == SFIELD_PRODUCT_EXP) return SFIELD_ERR_BASIS;
    job.s = scene;
    job.sets = set;
    job.set_count = 1;
    job.incident = coefs;
    return sfield__shade_all(&job, NULL);
}

/* ---- >>sparse ---- */

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

/* First of the cells, sorted, that is not before a place; its representative is chosen[first]. */
static const sfield__cell *sfield__find_cell(const sfield__cell *cells, size_t count, const sfield__cell *wanted)
{
    size_t low = 0, high = count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (sfield__compare_cells(&cells[middle], wanted) < 0) low = middle + 1;
        else high = middle;
    }
    if (low == count || cells[low].x != wanted->x || cells[low].y != wanted->y || cells[low].z != wanted->z ||
        cells[low].side != wanted->side)
        return NULL;
    return &cells[low];
}

/* The three representatives nearest to a point among the 27 cells around it whose surface faces the same way. */
static void sfield__sources(const sfield__cell *cells, size_t count, const sfield__cell *own, const float *positions,
                            float spacing, const uint32_t *chosen, uint32_t *sources, float *weights)
{
    float best[3] = { 3e38f, 3e38f, 3e38f }, sum = 0;
    const float *p = positions + 3 * (size_t)own->point, unit = sfield__unit(spacing);
    int32_t i;
    uint32_t k, j;
    sources[0] = sources[1] = sources[2] = 0;
    for (i = 0; i < 27; i++) {
        sfield__cell wanted = *own;
        const sfield__cell *c;
        float d2 = 0, to;
        wanted.x += i % 3 - 1;
        wanted.y += i / 3 % 3 - 1;
        wanted.z += i / 9 - 1;
        wanted.point = 0;
        c = sfield__find_cell(cells, count, &wanted);
        if (!c) continue;
        for (k = 0; k < 3; k++) {
            to = positions[3 * (size_t)chosen[c->point] + k] * unit - p[k] * unit;
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
    for (k = 0; k < 3; k++) {                   /* inverse distances; the own representative alone where it is hit */
        weights[k] = best[k] < 3e38f ? 1 / (best[k] + 1e-30f) : 0;
        sum += weights[k];
    }
    for (k = 0; k < 3; k++) {
        weights[k] /= sum;
        if (best[k] >= 3e38f) sources[k] = sources[0];
    }
}

SFIELD_DEF sfield_result sfield_sparse(const float *positions, const float *normals, size_t count, float spacing,
                                       const sfield_allocator *allocator, uint32_t *chosen, size_t *chosen_count,
                                       uint32_t *sources, float *weights)
{
    sfield__allocator a = sfield__allocator_of(allocator);
    sfield__cell *cells, *first;
    float best = 3e38f;
    size_t i, n = 0;
    uint32_t k;
    if (!positions || !normals || !count || count > 0x7fffffffu || !(spacing > 0) || !sfield__finite(spacing) ||
        !chosen || !chosen_count || !sources || !weights ||
        (allocator && !sfield__allocator_valid(allocator->alloc_fn, allocator->free_fn)))
        return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < 3 * count; i++)
        if (!sfield__in(positions[i] / spacing, -1e9f, 1e9f) || !sfield__finite(normals[i])) return SFIELD_ERR_ARGUMENT;
    cells = (sfield__cell *)sfield__alloc_array(&a, 2 * count, sizeof *cells);
    if (!cells) return SFIELD_ERR_ALLOC;
    first = cells + count;
    for (i = 0; i < count; i++) {
        const float *p = positions + 3 * i;
        int32_t at[3];
        for (k = 0; k < 3; k++) at[k] = (int32_t)(p[k] / spacing) - (p[k] < 0);
        cells[i].x = at[0];
        cells[i].y = at[1];
        cells[i].z = at[2];
        cells[i].side = (int32_t)sfield__face_of(normals + 3 * i);
        cells[i].point = (uint32_t)i;
    }
    qsort(cells, count, sizeof *cells, sfield__compare_cells);
    for (i = 0; i < count; i++) {               /* the point nearest to a cell's middle stands for it */
        const float *p = positions + 3 * (size_t)cells[i].point;
        float middle[3], d2 = 0;
        middle[0] = (float)cells[i].x;
        middle[1] = (float)cells[i].y;
        middle[2] = (float)cells[i].z;
        for (k = 0; k < 3; k++) d2 += (p[k] / spacing - middle[k] - 0.5f) * (p[k] / spacing - middle[k] - 0.5f);
        if (!i || cells[i].x != cells[i - 1].x || cells[i].y != cells[i - 1].y || cells[i].z != cells[i - 1].z ||
            cells[i].side != cells[i - 1].side) {
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
        sfield__sources(first, n, &cells[i], positions, spacing, chosen, sources + 3 * (size_t)cells[i].point,
                        weights + 3 * (size_t)cells[i].point);
    *chosen_count = n;
    sfield__free(&a, cells);
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_spread(size_t count, const uint32_t *sources, const float *weights, size_t chosen_count,
                                       const float *rgb, float *out)
{
    size_t i, k, c;
    if (!sources || !weights || !rgb || !out) return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < 3 * count; i++)
        if (sources[i] >= chosen_count) return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < count; i++)
        for (c = 0; c < 3; c++) {
            float sum = 0;
            for (k = 0; k < 3; k++) sum += weights[3 * i + k] * rgb[3 * (size_t)sources[3 * i + k] + c];
            out[3 * i + c] = sum;
        }
    return SFIELD_OK;
}

SFIELD_DEF const char *sfield_result_text(sfield_result result)
{
    static const char *const texts[] = {
#define SFIELD__TEXT(name, text) text,
        SFIELD_RESULTS(SFIELD__TEXT)
#undef SFIELD__TEXT
    };
    return (uint32_t)result < SFIELD_RESULT_COUNT ? texts[result] : "unknown result";
}

/* >>> shared fp_end: written by tools/stamp from src/shared, edit there */

/* unit fp_end: the user's options again. clang and MSVC keep contraction off to the end of the file. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__)
#pragma GCC pop_options
#endif

/* <<< shared */

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
