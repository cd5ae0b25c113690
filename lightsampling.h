/* lightsampling.h - v1.0.0 - direct light by sampling: lights, materials, the estimator - MIT-0 OR Unlicense

   What it does

   Estimates the direct light of one lamp or sky at arrays of points: it draws directions towards the light,
   weighs each of them with material and light, and sums up those that are visible. You say which samples are
   visible, in a plain array of floats: from csm.h's maps, from rays (Embree, your own tracer), or from any
   shadow map. The method is that of section 5 of Ritschel, Grosch, Kautz and Mueller, "Interactive
   Illumination with Coherent Shadow Maps", EGSR 2007.

   What it does not do

   - It does not find out what blocks light, and it renders nothing: points, normals, directions to the eye
     and visibility are yours.
   - Light comes straight from the lamp; nothing bounces.
   - It opens no files, allocates no memory and starts no threads.

   Quick start

   Write the define in exactly one source file; include the header alone everywhere else.

       #define LIGHTSAMPLING_IMPLEMENTATION
       #include "lightsampling.h"
       #include <stdio.h>

       enum { SAMPLES = 256 };

       int main(void)
       {
           // a square lamp over a white point; a big card hides the half of it with x < 0
           static float directions[3 * SAMPLES], distances[SAMPLES], weights[3 * SAMPLES], visible[SAMPLES];
           static double memory[512];
           const float at[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
           static lsamp_light_desc lamp;                                  // static: all zero, the defaults
           static lsamp_material white;
           static lsamp_points points;
           static lsamp_sample_desc desc;
           lsamp_samples samples = { directions, distances, NULL, weights };
           lsamp_light *light;
           float open[3] = { 0, 0, 0 }, half[3] = { 0, 0, 0 };
           int i;

           lamp.kind = LSAMP_LIGHT_RECTANGLE;
           lamp.position[0] = lamp.position[2] = -1;                   // corner and edges; it shines down
           lamp.position[1] = 2;
           lamp.u[0] = lamp.v[2] = 2;
           lamp.radiance[0] = lamp.radiance[1] = lamp.radiance[2] = 1;
           white.diffuse[0] = white.diffuse[1] = white.diffuse[2] = 1;
           desc.sample_count = SAMPLES;
           points.count = 1;
           points.positions = at;
           points.normals = up;
           points.materials = &white;
           if (lsamp_light_init(&lamp, memory, sizeof memory, &light, NULL) != LSAMP_OK) return 1;
           if (lsamp_sample(&desc, light, &points, &samples, NULL) != LSAMP_OK) return 1;
           for (i = 0; i < SAMPLES; i++) visible[i] = directions[3 * i] >= 0 ? 1.0f : 0.0f;     // your answer
           lsamp_accumulate(1, SAMPLES, weights, NULL, open, 0);
           lsamp_accumulate(1, SAMPLES, weights, visible, half, 0);
           printf("radiance %.3f, half hidden %.3f\n", (double)open[0], (double)half[0]);
           return !(open[0] > 0.23f && open[0] < 0.25f && half[0] > 0.11f && half[0] < 0.13f);
       }

   Conventions

   Coordinates are right-handed; directions have unit length and point from the surface to the light or the
   eye; distances are in the scene's units, angles in radians, radiance in W/(sr m^2). A vector that is called
   unit may have a length from 0.97 to 1.03 and is used as it is; any other length is an error. The poles of
   skies, of latitude-longitude maps and of `rotation` are +Y and -Y: turn a scene whose up is Z before it
   comes here.

     light      a shape A that emits (section 5), its light function L, and how points of it are drawn, P_L
     coords     a light's own coordinates x in [0, 1)^d; equal ranges of them cover equal areas of the light
     domain     D of section 4: the directions or positions that visibility maps for a light must be made for
     material   a BRDF f with its parameters at one point, and how directions are drawn from it, P_f
     sample     one direction towards a light with its weight f L cos / (pdf S), for S samples a point
     pattern    points in the unit square from which all samples of one pixel take their random numbers
                (section 5.1)

   How it works

   L(x, wo) = integral of f(x, wo, w) L_in(x, w) V(x, w) cos(theta) dw, in three steps that arrays of points
   share:

       lsamp_sample      for each point S directions towards one light, each with its weight f L cos / (pdf S)
       visible           yours: one float a sample, 1 lit, 0 hidden; a sample of weight 0 needs none
       lsamp_accumulate  adds weight x visibility up

   Several lights are several calls. Calls on the same light may run on several threads at once.

   From the paper to the code

     section 5     the direct lighting equation      lsamp_sample, lsamp_accumulate           T10, T20, T23
     section 5     A, a light's shape (figure 12)    lsamp_light_kind, lsamp__shape_point     T43, T73
     section 5     A as a table, linearly filtered   lsamp_surface, lsamp__surface_point      T43, T73
     section 5     L, texels, and frames over time   lsamp_light_desc, lsamp__emitter_frame   T18, T22
     section 5     L, linear filtering (figure 12)   lsamp_texels, lsamp__texel_at            T43
     section 5     emitters that are not Lambertian  lsamp__emit                              T43
     section 4, 5  D, where maps look from           lsamp_light_domain                       -
                                                     lsamp_surface_locations                  -
     section 5.1   the mean of f L V cos / p         lsamp__estimate                          T10, T73
     section 5.1   P_L, the inverse of a CDF         lsamp__emitter_cdf, lsamp__invert_sums   T11, T12, T15
     section 5     a material for each pixel         lsamp_points (materials)                 -
     section 5.1   P_f, lobes by Russian roulette    lsamp_brdf_sample, lsamp__brdf_draw      T10, T21
     section 5.1   256 patterns, one for a pixel     lsamp_patterns_build, lsamp__random_numbers  -
     section 5.1   sky: diffuse by P_L, specular by  lsamp_sampling, lsamp__estimator_init    T10
                   P_f; local lights by P_L
     section 5.2   the mean of frames (figure 11)    lsamp_progressive_add                    T16

   The last column names the rows of docs/conformance.md that test a line; a - says that there is none.
   tests/lightsampling holds patterns to what makes them stratified and to an integral, and samples of points
   with materials of their own to golden bytes. Visibility V and the rest of the paper are csm.h's.
   docs/lightsampling.md says where the code departs from the paper, and why.

   Configuration

     LIGHTSAMPLING_IMPLEMENTATION   in one source file: compiles the code
     LSAMP_STATIC                   beside it: a private copy for this file, all functions static
     LSAMP_DEF                      everywhere: your own linkage instead

   Memory, errors, threads, determinism

   Nothing here allocates: lights, patterns and sums live in memory that you own. Every function that can fail
   returns an lsamp_result; if the result is not LSAMP_OK, outputs are untouched. The log of a desc says why a
   call failed, unless the desc is NULL; calls without a desc say at their declarations that they have no log.
   There are no globals: any number of threads may sample the same light; sums of frames belong to one thread
   at a time. A point's samples depend on its own inputs and pixel only, and are the same bits on every
   compiler and processor (not with x87 arithmetic, nor with clang's -ffast-math).

   What is supported: docs/lightsampling.md.   History: CHANGELOG.md.   Licence: end of this file. */
#ifndef LIGHTSAMPLING_H
#define LIGHTSAMPLING_H

#define LSAMP_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "lightsampling.h needs C99 or C++11"
#endif
#if defined(LSAMP_STATIC) && !defined(LIGHTSAMPLING_IMPLEMENTATION)
#error "LSAMP_STATIC makes all functions private: LIGHTSAMPLING_IMPLEMENTATION belongs into the same file"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef LSAMP_DEF
#ifdef LSAMP_STATIC
#define LSAMP_DEF static inline
#else
#define LSAMP_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif


/* ==== src/lightsampling/api_page_one.h ==== */

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

/* ==== src/lightsampling/api_frames.h ==== */

/* ---- over frames ---- */

typedef struct lsamp_progressive {  /* sums of frames, from which their mean is taken (section 5.2); set sums
                                       and count, then call lsamp_progressive_reset */
    double  *sums;                  /* count doubles in your memory; precise enough for 1e6 frames */
    size_t   count;                 /* 3 x pixels */
    uint32_t frame_count;           /* how many frames the sums hold */
} lsamp_progressive;

LSAMP_DEF lsamp_result lsamp_progressive_reset(lsamp_progressive *p);
/* Forgets all frames. Call it before the first frame and after every change of camera, scene or light.
   Errors   LSAMP_ERR_ARGUMENT (NULL). There is no log */

LSAMP_DEF lsamp_result lsamp_progressive_add(lsamp_progressive *p, const float *frame);
/* Adds a frame of count floats to the sums.
   Errors   LSAMP_ERR_ARGUMENT (NULL), LSAMP_ERR_LIMIT (there are 2^32 - 1 frames). There is no log */

LSAMP_DEF lsamp_result lsamp_progressive_mean(const lsamp_progressive *p, float *mean);
/* Writes the mean of the frames, count floats.
   Errors   LSAMP_ERR_ARGUMENT (NULL), LSAMP_ERR_ORDER (there is no frame yet). There is no log */

#define LSAMP_PATTERN_COUNT 256u    /* patterns that lsamp_patterns_build makes, as in the paper */

LSAMP_DEF size_t lsamp_patterns_bytes(uint32_t length);
/* Returns the bytes that lsamp_patterns_build needs for LSAMP_PATTERN_COUNT patterns of length points; 0 if
   length is not 1..65536. */

LSAMP_DEF lsamp_result lsamp_patterns_build(uint32_t length, uint32_t seed, float *patterns, size_t bytes);
/* Makes the paper's stratified patterns of points in the unit square (section 5.1), for
   lsamp_sample_desc.patterns. If the square is cut into length columns, each column holds one point of a
   pattern, jittered; if length is a power of 4, so does each cell of the square grid of length cells.
   lsamp_sample chooses a pattern by pixel and takes another one each frame; after 256 frames all have been
   used, and they come again, shifted.
   length    points of a pattern, 1..65536: the samples of each point, lsamp_sample_desc.sample_count
   patterns  receives the points, 2 floats each; those of pattern j begin at patterns + j * length * 2
   bytes     of patterns, at least lsamp_patterns_bytes(length)
   Errors    LSAMP_ERR_ARGUMENT (NULL, length), LSAMP_ERR_MEMORY (bytes). There is no log */

/* ==== src/lightsampling/api_lights.h ==== */

/* ---- lights, point by point, and where maps of them look from ---- */

typedef struct lsamp_emission {     /* one point of a light as seen from a point p */
    float direction[3];             /* unit, from p to the point of the light */
    float distance;                 /* from p to the point of the light; LSAMP_INFINITY for environment and
                                       sun */
    float coords[3];                /* the light's own coordinates of the point, in [0, 1); 0 for those that
                                       this kind of light does not have */
    float radiance[3];              /* from the light towards p, W/(sr m^2); of sun, point and spot the
                                       irradiance of a surface at p that faces the light, W/m^2 */
    float pdf;                      /* the density, per solid angle as seen from p, with which
                                       lsamp_light_sample draws this direction; 1 for sun, point and spot,
                                       which have one direction only */
} lsamp_emission;

LSAMP_DEF int lsamp_light_sample(const lsamp_light *light, const float p[3], const float u[3],
                                 lsamp_emission *out);
/* Draws a point of the light from the density P_L: in proportion to the texels (linear ones: to the mean over
   each), or, of rectangles and spheres without texels, evenly over the solid angle seen from p. Returns 1;
   returns 0 and leaves *out untouched if no light of the drawn point reaches p, or if an argument is NULL or
   out of range.
   u        random numbers in [0, 1); u[2] serves callbacks and meshes only */

LSAMP_DEF int lsamp_light_hit(const lsamp_light *light, const float p[3], const float direction[3],
                              lsamp_emission *out);
/* Writes the point of the light at which a ray from p would arrive if nothing stood between them. Returns 1;
   returns 0 and leaves *out untouched if the ray misses the light, or if an argument is NULL or out of range.
   Sun, point and spot have no area to hit; a callback cannot be intersected; and meshes and surfaces are not
   searched: for these the function always returns 0, and lsamp_light_sample is the only way to reach them.
   direction  unit */

LSAMP_DEF size_t lsamp_light_triangles(const lsamp_light *light, float *corners);
/* Returns the number of pieces that a mesh was cut into, 0 for other kinds, and writes the pieces in the
   order of the mesh's curve. A piece is a triangle; the areas of pieces differ by at most a factor of two,
   but for triangles of the mesh that are smaller still.
   corners  receives 9 floats a piece, x, y, z of each corner; NULL: the pieces are only counted */

LSAMP_DEF lsamp_result lsamp_surface_locations(const lsamp_surface *surface, uint32_t width, uint32_t height,
                                               float lift, float *locations);
/* Writes D for a LSAMP_LIGHT_SURFACE: the surface at the centres of width x height equal cells of its
   coordinates, for a domain of LSAMP_DOMAIN_TABLE with these sides, whose maps are asked by the samples'
   coords, which lie 12 bytes apart (cohsm_query.light_stride): side is width, height, 1, and location_count
   width * height.
   lift        how far the places stand above the side that emits, in the scene's units, lest the surface
               itself hides all; below 0: behind it
   locations   receives 4 floats for each cell, rows of width: x, y, z, 1. Where the surface's points are not
               finite they are not finite either: put other ones there, since csm.h refuses such locations
   Errors      LSAMP_ERR_ARGUMENT (NULL, a side of 0), LSAMP_ERR_INPUT (surface->points is NULL, its width or
               height, lift). There is no log */

typedef enum lsamp_domain_kind {    /* the numbers are those of cohsm_domain_kind */
    LSAMP_DOMAIN_DEFAULT,           /* = LSAMP_DOMAIN_LATLONG, which lsamp_light_domain writes in its place */
    LSAMP_DOMAIN_LATLONG = 1,       /* directions: s = 0.5 + atan2(z, x) / 2 pi, t = acos(y) / pi */
    LSAMP_DOMAIN_LINE = 3,          /* positions: origin + s u */
    LSAMP_DOMAIN_RECTANGLE = 4,     /* positions: origin + s u + t v */
    LSAMP_DOMAIN_DISC = 5,          /* positions on a disc about origin; u and v are its two half axes */
    LSAMP_DOMAIN_SPHERE = 6,        /* positions on the sphere of radius |u| about origin; s turns about +Y,
                                       t runs with equal areas from +Y to -Y */
    LSAMP_DOMAIN_TABLE = 8,         /* positions: locations, asked by a parameter 0..1 */
    LSAMP_DOMAIN_LIST = 9,          /* positions: locations, asked by index */
    LSAMP_DOMAIN_COUNT
} lsamp_domain_kind;

typedef struct lsamp_domain {       /* has the fields of cohsm_domain (csm.h): copy them one by one into
                                       cohsm_desc.domain */
    lsamp_domain_kind kind;
    uint32_t side[3];               /* cells along each dimension; 0 = you choose */
    float origin[3], u[3], v[3], w[3];
    const float *locations;         /* TABLE, LIST: x, y, z, 1 each */
    size_t location_count;
} lsamp_domain;

LSAMP_DEF lsamp_result lsamp_light_domain(const lsamp_light *light, lsamp_domain *out);
/* Writes D of section 4: the directions or positions for which visibility maps, such as csm.h's, must be made
   so that they answer for samples of this light. Ask maps of a sky or a sun (LATLONG) with the samples'
   directions, maps of a point or a spot (LIST) with index 0, and all others with the samples' coords, three
   floats each (csm.h: COHSM_LIGHT_PARAMETER, light_stride 12).
   out      side is 0, which csm.h takes for its default, except for the TABLE of a mesh; the locations of
            LIST and TABLE lie in the light's memory
   Errors   LSAMP_ERR_ARGUMENT (NULL), LSAMP_ERR_MISMATCH (a callback or a surface: make a table of
            positions from shape_fn, or by lsamp_surface_locations) */

/* ---- materials, direction by direction ---- */

LSAMP_DEF lsamp_result lsamp_brdf_eval(const lsamp_material *material, const float normal[3],
                                       const float tangent[3], const float to_eye[3],
                                       const float direction[3], float f[3], float *pdf);
/* Writes f(wo, wi), the BRDF in 1/sr without the cosine, for wo = to_eye and wi = direction, and the density
   per solid angle with which lsamp_brdf_sample draws the direction.
   tangent    unit; made orthogonal to normal. NULL = any direction
   to_eye     unit, away from the surface; below it, it is lifted to just above
   direction  unit, away from the surface; f is 0 if it points below
   f          receives red, green, blue
   Errors   LSAMP_ERR_ARGUMENT (NULL), LSAMP_ERR_INPUT (a vector that is not unit, material). There is no log,
            for this is called for each direction: lsamp_sample's log names what is wrong with a material */

LSAMP_DEF lsamp_result lsamp_brdf_sample(const lsamp_material *material, const float normal[3],
                                         const float tangent[3], const float to_eye[3], const float u[2],
                                         float direction[3], float f[3], float *pdf);
/* Draws a direction from the material's density P_f, and writes f and the density as lsamp_brdf_eval does. A
   *pdf of 0 says that there is no sample, because the drawn direction points below the surface or the
   material is black; the direction is the normal then.
   u        random numbers in [0, 1): u[0] chooses the lobe by Russian roulette and is then stretched to 0..1
            again
   Errors   those of lsamp_brdf_eval; LSAMP_ERR_INPUT also for u. There is no log */

/* ==== src/lightsampling/api_end.h ==== */

#ifdef __cplusplus
}
#endif

#endif /* LIGHTSAMPLING_H */

/* ==== src/lightsampling/begin.h ==== */

/* ==== implementation ==================================================================================== */

#if defined(LIGHTSAMPLING_IMPLEMENTATION) && !defined(LIGHTSAMPLING_IMPLEMENTED)
#define LIGHTSAMPLING_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== src/shared/fp_begin.h ==== */

/* unit fp_begin: the arithmetic that the bytes depend on, from here to unit fp_end */

/* Forbids fused multiply-adds that the source does not ask for: gcc fuses across statements in its gnu modes
   and on s390x, clang within expressions. For gcc, the pragmas take a user's -ffast-math back. In clang,
   -ffast-math and -ffp-contract=fast win over the pragma: results then stay within tolerance, but are not
   equal to the bit. */
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#define LSAMP__FINITE_MATH 1
#else
#define LSAMP__FINITE_MATH 0
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

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
static inline int lsamp__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

static inline int lsamp__add_size(size_t a, size_t b, size_t *out)
{
    if (a > SIZE_MAX - b) return 0;
    *out = a + b;
    return 1;
}

/* Returns 1 if so many bytes may lie between elements of floats that are `standard` bytes large: 0, which
   stands for `standard`, or a multiple of 4 with which elements do not overlap. */
static inline int lsamp__stride_valid(size_t stride, size_t standard)
{
    return stride == 0 || (stride >= standard && stride % 4 == 0);
}

/* ==== src/shared/v3.h ==== */

/* unit v3: three floats */

/* tcc 0.9.27 stores a returned struct of 12 bytes as 16, over the caller's next variable. */
typedef struct lsamp__v3 {
    float x, y, z;
#ifdef __TINYC__
    float unused;
#endif
} lsamp__v3;

static inline lsamp__v3 lsamp__v3_make(float x, float y, float z)
{
    lsamp__v3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

static inline lsamp__v3 lsamp__v3_load(const float *p) { return lsamp__v3_make(p[0], p[1], p[2]); }
static inline void lsamp__v3_store(float *p, lsamp__v3 v) { p[0] = v.x; p[1] = v.y; p[2] = v.z; }

static inline lsamp__v3 lsamp__v3_add(lsamp__v3 a, lsamp__v3 b)
{
    return lsamp__v3_make(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline lsamp__v3 lsamp__v3_sub(lsamp__v3 a, lsamp__v3 b)
{
    return lsamp__v3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline lsamp__v3 lsamp__v3_mul(lsamp__v3 a, lsamp__v3 b)
{
    return lsamp__v3_make(a.x * b.x, a.y * b.y, a.z * b.z);
}

static inline lsamp__v3 lsamp__v3_scale(lsamp__v3 a, float s)
{
    return lsamp__v3_make(a.x * s, a.y * s, a.z * s);
}

/* Returns a + b s. */
static inline lsamp__v3 lsamp__v3_madd(lsamp__v3 a, lsamp__v3 b, float s)
{
    return lsamp__v3_make(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s);
}

static inline float lsamp__v3_dot(lsamp__v3 a, lsamp__v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float lsamp__v3_length(lsamp__v3 a)
{
    return sqrtf(lsamp__v3_dot(a, a));
}

static inline lsamp__v3 lsamp__v3_cross(lsamp__v3 a, lsamp__v3 b)
{
    return lsamp__v3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline lsamp__v3 lsamp__v3_min(lsamp__v3 a, lsamp__v3 b)
{
    return lsamp__v3_make(a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z);
}

static inline lsamp__v3 lsamp__v3_max(lsamp__v3 a, lsamp__v3 b)
{
    return lsamp__v3_make(a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z);
}

/* Returns a with length 1. The largest component scales the others first, so that neither tiny nor huge
   vectors leave the range of floats. The zero vector stays zero. */
static inline lsamp__v3 lsamp__v3_normalize(lsamp__v3 a)
{
    float x = fabsf(a.x), y = fabsf(a.y), z = fabsf(a.z), m = x > y ? x : y;
    m = m > z ? m : z;
    if (!(m > 0.0f)) return lsamp__v3_make(0.0f, 0.0f, 0.0f);
    if (m < 1e-30f) {
        a = lsamp__v3_scale(a, 1e30f);
        m *= 1e30f;
    }
    a = lsamp__v3_make(a.x / m, a.y / m, a.z / m);
    m = lsamp__v3_length(a);
    return lsamp__v3_make(a.x / m, a.y / m, a.z / m);
}

/* Returns 1 if x is finite, by its exponent bits: under -ffast-math compilers may take isfinite() for always
   true. */
static inline int lsamp__finite(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7f800000u) != 0x7f800000u;
}

static inline int lsamp__in(float x, float low, float high) { return lsamp__finite(x) && x >= low && x <= high; }

static inline int lsamp__v3_finite(lsamp__v3 a)
{
    return lsamp__finite(a.x) && lsamp__finite(a.y) && lsamp__finite(a.z);
}

/* Writes b1 and b2, which are orthonormal and right-handed together with a unit n; n.z may be -0 or -1. Duff
   et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017. */
static inline void lsamp__v3_basis(lsamp__v3 n, lsamp__v3 *b1, lsamp__v3 *b2)
{
    float s = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + n.z), b = n.x * n.y * a;
    *b1 = lsamp__v3_make(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
    *b2 = lsamp__v3_make(b, s + n.y * n.y * a, -n.y);
}

/* ==== src/shared/unit.h ==== */

/* unit unit: which vectors count as unit, the same in every header (src/README.md, "Unit vectors") */

/* The squares of the least and the greatest length that count as 1: an 8-bit normal map makes such
   vectors. */
#define LSAMP__UNIT_LEAST2 0.9409f       /* 0.97^2 */
#define LSAMP__UNIT_MOST2 1.0609f        /* 1.03^2 */

/* Says whether a vector is unit, by the square of its length. If that is not a number, the vector is not. */
static inline int lsamp__is_unit2(float length2)
{
    return length2 >= LSAMP__UNIT_LEAST2 && length2 <= LSAMP__UNIT_MOST2;
}

/* ==== src/shared/trig.h ==== */

/* unit trig: elementary functions with the same bits on every machine */

/* These functions use + - * / and sqrt alone, which IEEE 754 rounds the same everywhere as long as nothing
   is contracted (unit fp_begin). Coefficients are minimax fits of our own. The float functions are free of
   branches and calls, so that loops over them vectorise at SSE2 level. The errors named below are the
   largest differences from the double functions, over all float arguments or a dense set
   (tests/shared/units_test.c). Arguments out of range and NaN are clamped into the range, so that nothing
   here is undefined or returns NaN. */

static inline float lsamp__from_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline uint32_t lsamp__to_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* Returns |x| with the sign bit of s; s = -0 counts as negative. */
static inline float lsamp__copysign(float x, float s)
{
    return lsamp__from_bits((lsamp__to_bits(x) & 0x7fffffffu) | (lsamp__to_bits(s) & 0x80000000u));
}

/* Returns a if yes is 1 and b if it is 0, without a branch: compilers turn a chain of ?: with one condition
   into a branch, and then do not vectorise the loop round it. */
static inline float lsamp__either(int yes, float a, float b)
{
    uint32_t mask = 0u - (uint32_t)yes;
    return lsamp__from_bits((lsamp__to_bits(a) & mask) | (lsamp__to_bits(b) & ~mask));
}

/* Writes sine and cosine of |x| <= 8192 with an absolute error of 1e-7. As in Cody and Waite, pi/2 has three
   parts, of which the first two times k are exact for |k| < 2^13. */
static inline void lsamp__sincos(float x, float *sine, float *cosine)
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

static inline float lsamp__cos(float x)
{
    float s, c;
    lsamp__sincos(x, &s, &c);
    return c;
}

/* Returns asin of 0 <= x <= 0.5, with z = x * x. The functions made of it have an absolute error of 3e-7. */
static inline float lsamp__asin_core(float x, float z)
{
    return x + x * z * (0.1666675393f + z * (0.07495241769f + z * (0.04547709903f + z * (0.02414760004f +
                        z * 0.04221856856f))));
}

/* acos(x) is lsamp__acos_rooted(x, sqrtf(lsamp__acos_square(x))). The square root stands apart, since C compilers do
   not vectorise it. Above a half, asin(x) = pi/2 - 2 asin(sqrt((1 - x) / 2)) keeps acos exact near 0. */
static inline float lsamp__acos_square(float x)
{
    float a = fabsf(x);
    return 0.5f * (1.0f - lsamp__either(a < 1.0f, a, 1.0f));
}

static inline float lsamp__acos_rooted(float x, float root)
{
    float a = fabsf(x), h = lsamp__acos_square(x), p;
    int big = a > 0.5f;
    a = lsamp__either(a < 1.0f, a, 1.0f);
    p = lsamp__asin_core(lsamp__either(big, root, a), lsamp__either(big, h, a * a));
    p = lsamp__either(big, 2.0f * p, 1.57079633f - p);
    return lsamp__either(x < 0.0f, 3.14159265f - p, p);
}

static inline float lsamp__acos(float x) { return lsamp__acos_rooted(x, sqrtf(lsamp__acos_square(x))); }

/* Returns atan2 with an error of 4e-7, at most 3 ulp. All quadrants, zeros of either sign and infinities are
   as with C's atan2f; atan2(0, 0) is 0. */
static inline float lsamp__atan2(float y, float x)
{
    float ax = fabsf(x), ay = fabsf(y);
    float a, t, z, p;
    float hi = lsamp__either(ax > ay, ax, ay), lo = lsamp__either(ax > ay, ay, ax);
    int big;
    a = lsamp__either((lo == hi) & (hi > 0.0f), 1.0f, lo / lsamp__either(hi > 0.0f, hi, 1.0f));
    big = a > 0.414213562f;
    t = lsamp__either(big, (a - 1.0f) / (a + 1.0f), a);
    z = t * t;
    p = t + t * z * (-0.3333295525f + z * (0.1997792608f + z * (-0.1387984996f + z * 0.08060308882f)));
    p = lsamp__either(big, p + 0.785398163f, p);
    p = lsamp__either(ay > ax, 1.57079633f - p, p);
    p = lsamp__either((int)(lsamp__to_bits(x) >> 31), 3.14159265f - p, p);
    return lsamp__copysign(p, y);
}

/* Returns exp(x) as 2^k (1 + r + r^2 p(r)) with |r| <= ln 2 / 2, in double, so that exp, log and pow err by
   1 ulp. */
static inline double lsamp__exp_core(double x)
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
static inline double lsamp__log_core(float x)
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

/* Returns x^y. x below 0 counts as 0; 0^y is 0, 1 or infinity for y above, equal to or below 0. */
static inline float lsamp__pow(float x, float y)
{
    double t;
    if (y == 0.0f) return 1.0f;
    if (!(x > 0.0f)) return y > 0.0f ? 0.0f : lsamp__from_bits(0x7f800000u);
    t = (double)y * lsamp__log_core(x);
    return t > 88.722839111 ? lsamp__from_bits(0x7f800000u) : (float)lsamp__exp_core(t);
}

/* ==== src/shared/disc.h ==== */

/* unit disc, needs trig: the square mapped to the disc */

/* Writes where a point s, t of the unit square goes on the unit disc by Shirley and Chiu's concentric map,
   which keeps areas in proportion. */
static inline void lsamp__concentric(float s, float t, float *x, float *y)
{
    float a = 2.0f * s - 1.0f, b = 2.0f * t - 1.0f, r, phi;
    float sine, cosine;
    if (fabsf(a) > fabsf(b)) {
        r = a;
        phi = 0.785398163f * (b / a);
    } else {
        r = b;
        phi = b == 0.0f ? 0.0f : 1.57079633f - 0.785398163f * (a / b);
    }
    lsamp__sincos(phi, &sine, &cosine);
    *x = r * cosine;
    *y = r * sine;
}

/* ==== src/shared/hilbert.h ==== */

/* unit hilbert: Hilbert curves in 1 to 3 dimensions */

/* Returns the index of a cell, by the inverse of lsamp__hilbert_cell. */
static inline uint32_t lsamp__hilbert_index(const uint32_t *cell, uint32_t bits, uint32_t dims)
{
    uint32_t x[3] = { 0, 0, 0 }, index = 0;
    uint32_t i, b, q, t;

    for (i = 0; i < dims; i++) x[i] = cell[i];
    for (b = bits; b-- > 1u;) {
        q = (1u << b) - 1u;
        for (i = 0; i < dims; i++) {
            t = x[i] >> b & 1u ? 0u : (x[0] ^ x[i]) & q;
            x[0] ^= x[i] >> b & 1u ? q : t;
            x[i] ^= t;
        }
    }
    for (i = 1; i < dims; i++) x[i] ^= x[i - 1u];
    for (t = 0, b = bits; b-- > 1u;)
        if (x[dims - 1u] >> b & 1u) t ^= (1u << b) - 1u;
    for (i = 0; i < dims; i++) x[i] ^= t;
    for (i = 0; i < dims; i++)
        for (b = 0; b < bits; b++) index |= (x[i] >> b & 1u) << (b * dims + (dims - 1u - i));
    return index;
}

/* ==== src/shared/rng.h ==== */

/* unit rng: hashes and random numbers, the same on every machine */

/* Returns a hash by the output function of O'Neill's PCG: Jarzynski and Olano, "Hash functions for GPU
   rendering", JCGT 9(3), 2020. */
static inline uint32_t lsamp__hash32(uint32_t x)
{
    uint32_t state = x * 747796405u + 2891336453u;
    uint32_t word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

static inline uint32_t lsamp__hash_combine(uint32_t a, uint32_t b)
{
    return lsamp__hash32(a + 0x9e3779b9u * lsamp__hash32(b));
}

/* Returns the upper 24 bits as a number in [0, 1). Every such value is a float; the largest is 1 - 2^-24. */
static inline float lsamp__to_unit(uint32_t bits) { return (float)(bits >> 8) * (1.0f / 16777216.0f); }

/* Returns number i, in [0, 1), of the stream (seed, stream). There is no state, so that threads and tiles
   can draw their own numbers. */
static inline float lsamp__random(uint32_t seed, uint32_t stream, uint32_t i)
{
    return lsamp__to_unit(lsamp__hash_combine(lsamp__hash_combine(seed, stream), i));
}

/* ==== src/shared/lds.h ==== */

/* unit lds, needs rng: low-discrepancy points in [0, 1) */

static inline uint32_t lsamp__reverse_bits(uint32_t x)
{
    x = x >> 16 | x << 16;
    x = (x >> 8 & 0x00ff00ffu) | (x & 0x00ff00ffu) << 8;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    return (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
}

/* Returns x after Owen scrambling, by the hash of Laine and Karras as tuned in Burley, "Practical hash-based
   Owen scrambling", JCGT 9(4), 2020. It works on reversed bits: a bit depends on the more significant ones
   alone. */
static inline uint32_t lsamp__owen(uint32_t x, uint32_t seed)
{
    x = lsamp__reverse_bits(x) + seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return lsamp__reverse_bits(x);
}

/* Writes point i of a scrambled (0, 2)-sequence, which has the first two dimensions of Sobol's. The order is
   shuffled, too, so that sequences of different seeds may be combined to more dimensions. */
static inline void lsamp__sobol2(uint32_t i, uint32_t seed, float *u, float *v)
{
    uint32_t x, y = 0, d = 0x80000000u, k;
    i = lsamp__owen(i, lsamp__hash32(seed));
    x = lsamp__reverse_bits(i);
    for (k = i; k; k >>= 1, d ^= d >> 1)
        if (k & 1u) y ^= d;
    *u = lsamp__to_unit(lsamp__owen(x, lsamp__hash_combine(seed, 1u)));
    *v = lsamp__to_unit(lsamp__owen(y, lsamp__hash_combine(seed, 2u)));
}

/* ==== src/shared/cdf.h ==== */

/* unit cdf: piecewise-constant distributions in 1D and 2D, sampled by inversion */

/* A distribution over cells. sums[i] is the sum of the weights before cell i and sums[count] that of all;
   the array is the caller's. Sums are double, since a float sum of 1e6 small weights is wrong in the third
   digit. */
typedef struct lsamp__cdf { const double *sums; uint32_t count; } lsamp__cdf;

/* Makes a distribution of weights, each times `scale`, which is 1 for most callers. Negative, NaN and
   infinite weights count as 0; their number is returned. */
static inline size_t lsamp__cdf_build(lsamp__cdf *cdf, double *sums, const float *weights, uint32_t count, double scale)
{
    size_t bad = 0;
    double sum = 0.0;
    uint32_t i;

    for (i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, weights + i, sizeof bits);
        sums[i] = sum;
        if ((bits & 0x7fffffffu) == 0) continue;
        if ((bits & 0x7f800000u) == 0x7f800000u || bits >> 31) bad++;
        else sum += (double)weights[i] * scale;
    }
    sums[count] = sum;
    cdf->sums = sums;
    cdf->count = count;
    return bad;
}

static inline double lsamp__cdf_total(const lsamp__cdf *cdf) { return cdf->sums[cdf->count]; }

/* A distribution over the cells of a grid: `rows` is the one over whole rows, `sums` has that of each row. */
typedef struct lsamp__cdf2 { const double *rows, *sums; uint32_t width, height; } lsamp__cdf2;

/* Returns how many doubles a distribution over width * height cells needs; 0 if their size overflows. */
static inline size_t lsamp__cdf2_doubles(uint32_t width, uint32_t height)
{
    size_t row = (size_t)width + 1u, rows = (size_t)height + 1u;
    if (row == 0 || rows == 0 || height > (SIZE_MAX / sizeof(double) - rows) / row) return 0;
    return row * height + rows;
}

static inline double lsamp__cdf2_total(const lsamp__cdf2 *cdf) { return cdf->rows[cdf->height]; }

/* ==== src/shared/prefetch.h ==== */

/* unit prefetch: asks for a cache line before it is read, in headers without unit hot, which does so, too */

#if defined(__GNUC__) && !defined(__TINYC__)
#define LSAMP__PREFETCH(p) __builtin_prefetch(p)
#else
#define LSAMP__PREFETCH(p) ((void)(p))
#endif

/* ==== src/shared/message.h ==== */

/* unit message: one line for the caller's log that says why a call failed */

/* LSAMP__COLD stands before functions that are needed only by calls that fail: compilers make these functions
   small, and take branches to them for unlikely. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define LSAMP__COLD __attribute__((cold))
#else
#define LSAMP__COLD
#endif

/* Where a message goes, and the name of the function that failed. If log is NULL, nothing is written. */
typedef struct lsamp__logger {
    void (*log)(void *user, const char *message);
    void *user;
    const char *function;
} lsamp__logger;

typedef struct lsamp__message { char text[256]; size_t used; } lsamp__message;

/* Appends a text; what does not fit is cut off. */
static inline LSAMP__COLD void lsamp__message_text(lsamp__message *m, const char *s)
{
    while (*s && m->used + 1 < sizeof m->text) m->text[m->used++] = *s++;
    m->text[m->used] = 0;
}

static inline LSAMP__COLD void lsamp__message_count(lsamp__message *m, uint64_t value)
{
    char digits[24];
    size_t at = sizeof digits - 1;
    digits[at] = 0;
    do digits[--at] = (char)('0' + (int)(value % 10));
    while ((value /= 10) != 0);
    lsamp__message_text(m, digits + at);
}

/* Writes six significant digits without the zeros at their end. Returns how many digits are left and writes
   *exponent, the power of ten of the first one. value is finite and above 0. */
static inline LSAMP__COLD int lsamp__message_digits(double value, char digits[8], int *exponent)
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
static inline LSAMP__COLD void lsamp__message_number(lsamp__message *m, double value)
{
    char digits[8], first[2] = { 0, 0 };
    int exponent, count, i;

    if (value != value) {
        lsamp__message_text(m, "not a number");
        return;
    }
    if (value < 0.0) lsamp__message_text(m, "-");
    if (value < 0.0) value = -value;
    if (!(value > 0.0) || value > 1.7976931348623157e308) {
        lsamp__message_text(m, value > 0.0 ? "infinity" : "0");
        return;
    }
    if (value < 9007199254740992.0 && value - (double)(uint64_t)value <= 0.0) {
        lsamp__message_count(m, (uint64_t)value);
        return;
    }
    count = lsamp__message_digits(value, digits, &exponent);
    first[0] = digits[0];
    if (exponent < -4 || exponent > 9) {
        lsamp__message_text(m, first);
        if (count > 1) lsamp__message_text(m, ".");
        lsamp__message_text(m, digits + 1);
        lsamp__message_text(m, exponent < 0 ? "e-" : "e");
        lsamp__message_count(m, (uint64_t)(exponent < 0 ? -exponent : exponent));
        return;
    }
    if (exponent < 0) lsamp__message_text(m, "0.");
    for (i = exponent; i < -1; i++) lsamp__message_text(m, "0");
    for (i = 0; i < count; i++) {
        if (exponent >= 0 && i == exponent + 1) lsamp__message_text(m, ".");
        first[0] = digits[i];
        lsamp__message_text(m, first);
    }
    for (i = count; i <= exponent; i++) lsamp__message_text(m, "0");
}

/* Begins a line: "FUNCTION: FIELD". */
static inline LSAMP__COLD void lsamp__message_begin(lsamp__message *m,
                                          const lsamp__logger *logger, const char *field)
{
    m->used = 0;
    lsamp__message_text(m, logger->function);
    lsamp__message_text(m, ": ");
    lsamp__message_text(m, field);
}

/* Logs "FUNCTION: FIELD TEXT", as in "cohsm_build: mesh.positions is NULL". */
static inline LSAMP__COLD void lsamp__log_text(const lsamp__logger *logger, const char *field, const char *text)
{
    lsamp__message m;
    if (!logger->log) return;
    lsamp__message_begin(&m, logger, field);
    lsamp__message_text(&m, " ");
    lsamp__message_text(&m, text);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: FIELD is VALUE; it must be WANTED", as in "cohsm_build: desc.map_side is 3; it must be 0 or
   4..1024". */
static inline LSAMP__COLD void lsamp__log_value(const lsamp__logger *logger, const char *field, double value,
                                      const char *wanted)
{
    lsamp__message m;
    if (!logger->log) return;
    lsamp__message_begin(&m, logger, field);
    lsamp__message_text(&m, " is ");
    lsamp__message_number(&m, value);
    lsamp__message_text(&m, "; it must be ");
    lsamp__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: ARRAY[INDEX] WHAT VALUE; it must be WANTED", as in "rsm_gather: normals[17] has the length
   0.5; it must be 1 (0.97..1.03), or 0". */
static inline LSAMP__COLD void lsamp__log_element(const lsamp__logger *logger, const char *array, uint64_t index,
                                        const char *what, double value, const char *wanted)
{
    lsamp__message m;
    if (!logger->log) return;
    lsamp__message_begin(&m, logger, array);
    lsamp__message_text(&m, "[");
    lsamp__message_count(&m, index);
    lsamp__message_text(&m, "] ");
    lsamp__message_text(&m, what);
    lsamp__message_text(&m, " ");
    lsamp__message_number(&m, value);
    lsamp__message_text(&m, "; it must be ");
    lsamp__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: mesh: index 2 of triangle 17 is 90, but the mesh has 80 vertices". position counts the
   indices from 0. */
static inline LSAMP__COLD void lsamp__log_index(const lsamp__logger *logger, const char *mesh,
                                      uint64_t position, uint64_t index, uint64_t vertex_count)
{
    lsamp__message m;
    if (!logger->log) return;
    lsamp__message_begin(&m, logger, mesh);
    lsamp__message_text(&m, ": index ");
    lsamp__message_count(&m, position % 3);
    lsamp__message_text(&m, " of triangle ");
    lsamp__message_count(&m, position / 3);
    lsamp__message_text(&m, " is ");
    lsamp__message_count(&m, index);
    lsamp__message_text(&m, ", but the mesh has ");
    lsamp__message_count(&m, vertex_count);
    lsamp__message_text(&m, vertex_count == 1 ? " vertex" : " vertices");
    logger->log(logger->user, m.text);
}

/* ==== src/shared/bound.h ==== */

/* unit bound, needs message: the line for a number that is beyond what an object or an earlier call allows */

/* Logs "FUNCTION: FIELD is VALUE; it must be RELATION BOUND, NAME", as in "cohsm_view: view is 9; it must be
   below 8, the number of views". */
static inline LSAMP__COLD void lsamp__log_bound(const lsamp__logger *logger, const char *field, uint64_t value,
                                      const char *relation, uint64_t bound, const char *name)
{
    lsamp__message m;
    m.used = 0;
    lsamp__message_text(&m, relation);
    lsamp__message_text(&m, " ");
    lsamp__message_count(&m, bound);
    lsamp__message_text(&m, ", ");
    lsamp__message_text(&m, name);
    lsamp__log_value(logger, field, (double)value, m.text);
}

/* ==== src/lightsampling/numbers.h ==== */

/* ---- numbers: what lights and materials share ---- */

LSAMP_DEF const char *lsamp_result_text(lsamp_result result)
{
    switch (result) {
#define LSAMP__TEXT(name, text) case name: return text;
    LSAMP_RESULTS(LSAMP__TEXT)
#undef LSAMP__TEXT
    default: return "unknown result";
    }
}

#define LSAMP__PI 3.14159265f
#define LSAMP__BELOW_1 0.99999994f

static float lsamp__mean3(lsamp__v3 c) { return (c.x + c.y + c.z) * (1.0f / 3.0f); }
static float lsamp__clamp_unit(float u) { return u > 0.0f ? u < LSAMP__BELOW_1 ? u : LSAMP__BELOW_1 : 0.0f; }
static float lsamp__safe_sqrt(float x) { return x > 0.0f ? sqrtf(x) : 0.0f; }

/* Returns t w.x + b w.y + n w.z. */
static lsamp__v3 lsamp__from_axes(lsamp__v3 t, lsamp__v3 b, lsamp__v3 n, lsamp__v3 w)
{
    return lsamp__v3_madd(lsamp__v3_madd(lsamp__v3_scale(t, w.x), b, w.y), n, w.z);
}

/* Does the inverse of lsamp__concentric. */
static void lsamp__disc_square(float x, float y, float *u, float *v)
{
    float r = sqrtf(x * x + y * y), a, b;
    if (fabsf(x) > fabsf(y)) {
        a = x > 0.0f ? r : -r;
        b = a * (4.0f / LSAMP__PI) * lsamp__atan2(y / x, 1.0f);
    } else {
        b = y > 0.0f ? r : -r;
        a = r > 0.0f ? b * (4.0f / LSAMP__PI) * lsamp__atan2(x / y, 1.0f) : 0.0f;
    }
    *u = lsamp__clamp_unit(0.5f * (a + 1.0f));
    *v = lsamp__clamp_unit(0.5f * (b + 1.0f));
}

/* Says whether three floats are numbers within low..high. */
static int lsamp__in3(const float *p, float low, float high)
{
    int i;
    for (i = 0; i < 3; i++)
        if (!lsamp__finite(p[i]) || p[i] < low || p[i] > high) return 0;
    return 1;
}

static int lsamp__is_unit(const float *p)
{
    lsamp__v3 v = lsamp__v3_load(p);
    return lsamp__v3_finite(v) && lsamp__is_unit2(lsamp__v3_dot(v, v));
}

static lsamp__logger lsamp__logger_of(const lsamp_system *s, const char *function)
{
    lsamp__logger log;
    log.log = s->log;
    log.user = s->user;
    log.function = function;
    return log;
}

/* ==== src/lightsampling/mesh.h ==== */

/* ---- mesh: corners of a mesh that emits, and its checks ---- */

static const uint32_t *lsamp__corners(const lsamp_mesh *m, size_t triangle, uint32_t *scratch)
{
    int k;
    if (m->indices) return m->indices + 3 * triangle;
    for (k = 0; m->indices16 && k < 3; k++) scratch[k] = m->indices16[3 * triangle + (size_t)k];
    if (m->indices16) return scratch;
    scratch[0] = (uint32_t)(3 * triangle);
    scratch[1] = scratch[0] + 1;
    scratch[2] = scratch[0] + 2;
    return scratch;
}

static lsamp__v3 lsamp__vertex(const lsamp_mesh *m, uint32_t i)
{
    size_t stride = m->vertex_stride ? m->vertex_stride : 12;
    float p[3];
    memcpy(p, (const char *)m->positions + stride * i, sizeof p);
    return lsamp__v3_load(p);
}

static size_t lsamp__corner_count(const lsamp_mesh *m)
{
    return m->indices || m->indices16 ? m->index_count : m->vertex_count;
}

static size_t lsamp__triangle_count(const lsamp_mesh *m) { return lsamp__corner_count(m) / 3; }

/* Logs what a field of the mesh is, and returns the result. log may be NULL. */
static lsamp_result lsamp__mesh_refuse(const lsamp__logger *log, lsamp_result result, const char *field,
                                       const char *text)
{
    if (log) lsamp__log_text(log, field, text);
    return result;
}

/* Logs that a number of the mesh is out of its range, and returns the result. log may be NULL. */
static lsamp_result lsamp__mesh_refuse_value(const lsamp__logger *log, lsamp_result result, const char *field,
                                             size_t value, const char *wanted)
{
    if (log) lsamp__log_value(log, field, (double)value, wanted);
    return result;
}

static lsamp_result lsamp__indices_check(const lsamp_mesh *m, size_t count, const lsamp__logger *log)
{
    size_t i;
    uint32_t index;
    for (i = 0; (m->indices || m->indices16) && i < count; i++) {
        index = m->indices ? m->indices[i] : m->indices16[i];
        if (index < m->vertex_count) continue;
        if (log) lsamp__log_index(log, "desc.mesh", i, index, m->vertex_count);
        return LSAMP_ERR_INPUT;
    }
    return LSAMP_OK;
}

static lsamp_result lsamp__mesh_check(const lsamp_mesh *m, const lsamp__logger *log)
{
    const lsamp_result bad = LSAMP_ERR_ARGUMENT;
    const char *name;
    size_t count;
    if (!m) return lsamp__mesh_refuse(log, LSAMP_ERR_DESC, "desc.mesh", "is NULL");
    if (!m->positions) return lsamp__mesh_refuse(log, bad, "desc.mesh.positions", "is NULL");
    if (m->indices && m->indices16)
        return lsamp__mesh_refuse(log, bad, "desc.mesh.indices16", "is set beside indices");
    if (!lsamp__stride_valid(m->vertex_stride, 12))
        return lsamp__mesh_refuse_value(log, bad, "desc.mesh.vertex_stride", m->vertex_stride,
                                        "0 or a multiple of 4 from 12 on");
    if (!m->vertex_count || m->vertex_count > 0x7fffffffu)
        return lsamp__mesh_refuse_value(log, m->vertex_count ? LSAMP_ERR_LIMIT : bad,
                                        "desc.mesh.vertex_count", m->vertex_count, "1..2^31 - 1");
    name = m->indices || m->indices16 ? "desc.mesh.index_count" : "desc.mesh.vertex_count";
    count = lsamp__corner_count(m);
    if (count == 0 || count % 3)
        return lsamp__mesh_refuse_value(log, bad, name, count, "a multiple of 3, 3..2^31 - 1");
    if (count > 0x7fffffffu)
        return lsamp__mesh_refuse_value(log, LSAMP_ERR_LIMIT, name, count, "a multiple of 3, 3..2^31 - 1");
    return lsamp__indices_check(m, count, log);
}

/* ==== src/lightsampling/brdf.h ==== */

/* ---- brdf: a material at a point, evaluated and sampled ---- */

typedef struct lsamp__cosine_lobe { /* scale max(0, axis . wi)^exponent */
    lsamp__v3 axis, scale;
    float     exponent;
} lsamp__cosine_lobe;

typedef struct lsamp__surface {  /* a material at one point; all directions are along the axes t, b, n */
    lsamp__v3 t, b, n;           /* tangent, bitangent and normal, orthonormal */
    lsamp__v3 to_eye;                /* the direction to the eye */
    lsamp__v3 diffuse;           /* the albedo of the diffuse part */
    lsamp__v3 f0;                /* METAL_ROUGH: the reflectance along the normal */
    float     alpha;             /* METAL_ROUGH: of GGX; 0: the specular part consists of cosine lobes */
    uint32_t  lobe_count;
    lsamp__cosine_lobe lobes[LSAMP_MAX_LOBES];
    float     lobe_share[LSAMP_MAX_LOBES]; /* the probability that roulette takes a lobe; the sum is 1 */
    float     diffuse_share;     /* the probability that it takes the diffuse part: k_d of the paper */
    float     peak;              /* roughly the largest density of the BRDF's samples, 1/sr */
    int       black;             /* nothing is reflected */
} lsamp__surface;

typedef struct lsamp__response { /* f and density for one wi, of the diffuse and the specular part apart */
    lsamp__v3 diffuse, specular;
    float     diffuse_pdf, specular_pdf;
} lsamp__response;

static lsamp__v3 lsamp__to_axes(const lsamp__surface *s, lsamp__v3 w)
{
    return lsamp__v3_make(lsamp__v3_dot(w, s->t), lsamp__v3_dot(w, s->b), lsamp__v3_dot(w, s->n));
}

static float lsamp__pow5(float x) { return x * x * (x * x) * x; }

static lsamp__v3 lsamp__schlick(lsamp__v3 f0, float cosine)
{
    float f = lsamp__pow5(1.0f - cosine);
    return lsamp__v3_madd(lsamp__v3_scale(f0, 1.0f - f), lsamp__v3_make(1.0f, 1.0f, 1.0f), f);
}

/* A field of a material that is out of range: its name, its value, and where the value must lie. */
typedef struct lsamp__fault { const char *field, *wanted; float value; } lsamp__fault;

/* Says whether each of count values is a number within low..high; if not, sets the fault. */
static int lsamp__values_in(lsamp__fault *f, const char *field, const float *values, int count, float low,
                       float high, const char *wanted)
{
    int k;
    for (k = 0; k < count; k++) {
        if (lsamp__in(values[k], low, high)) continue;
        f->field = field;
        f->value = values[k];
        f->wanted = wanted;
        return 0;
    }
    return 1;
}

static int lsamp__lobes_valid(const lsamp_material *m, lsamp__fault *f)
{
    uint32_t i;
    float count = (float)m->lobe_count;

    if (!lsamp__values_in(f, "has the lobe_count", &count, 1, 0.0f, (float)LSAMP_MAX_LOBES, "0..8")) return 0;
    if (!lsamp__values_in(f, "has no lobes, but the lobe_count", &count, 1, 0.0f, m->lobes ? count : 0.0f,
                     "0 then"))
        return 0;
    for (i = 0; i < m->lobe_count; i++)
        if (!lsamp__values_in(f, "has a lobe with the axis", m->lobes[i].axis, 3, -10.0f, 10.0f, "-10..10") ||
            !lsamp__values_in(f, "has a lobe with the scale", m->lobes[i].scale, 3, 0.0f, 1e9f, "0..1e9") ||
            !lsamp__values_in(f, "has a lobe with the exponent", &m->lobes[i].exponent, 1, 0.0f, 1e5f,
                         "0..100000"))
            return 0;
    return 1;
}

static int lsamp__material_valid(const lsamp_material *m, lsamp__fault *f)
{
    float kind = (float)m->kind;

    if (!lsamp__values_in(f, "has the kind", &kind, 1, 0.0f, (float)LSAMP_MATERIAL_COUNT - 1.0f,
                     "a LSAMP_MATERIAL_...") ||
        !lsamp__values_in(f, "has the diffuse", m->diffuse, 3, 0.0f, 1.0f, "0..1"))
        return 0;
    if (m->kind == LSAMP_MATERIAL_PHONG)
        return lsamp__values_in(f, "has the specular", m->specular, 3, 0.0f, 1.0f, "0..1") &&
               lsamp__values_in(f, "has the exponent", &m->exponent, 1, 0.0f, 1e5f, "0..100000");
    if (m->kind == LSAMP_MATERIAL_METAL_ROUGH)
        return lsamp__values_in(f, "has the metallic", &m->metallic, 1, 0.0f, 1.0f, "0..1") &&
               lsamp__values_in(f, "has the roughness", &m->roughness, 1, 0.0f, 1.0f, "0..1");
    return m->kind != LSAMP_MATERIAL_LAFORTUNE || lsamp__lobes_valid(m, f);
}

/* Adds a lobe about C to_eye, and returns roughly its albedo, which only steers the roulette. */
static float lsamp__add_lobe(lsamp__surface *s, lsamp__v3 c, float exponent, lsamp__v3 scale)
{
    lsamp__cosine_lobe *lobe = &s->lobes[s->lobe_count];
    lsamp__v3 a = lsamp__v3_mul(c, s->to_eye);
    float length = lsamp__v3_length(a), albedo;

    if (!(length > 0.0f)) return 0.0f;
    lobe->axis = lsamp__v3_scale(a, 1.0f / length);
    lobe->exponent = exponent;
    lobe->scale = lsamp__v3_scale(scale, exponent > 0.0f ? lsamp__pow(length, exponent) : 1.0f);
    albedo = lsamp__mean3(lobe->scale) * 2.0f * LSAMP__PI / (exponent + 2.0f);
    albedo *= lobe->axis.z > 0.1f ? lobe->axis.z : 0.1f;
    if (!(albedo > 0.0f) || !lsamp__v3_finite(lobe->scale)) return 0.0f;
    s->lobe_share[s->lobe_count++] = albedo;
    return albedo;
}

static float lsamp__specular_init(lsamp__surface *s, const lsamp_material *m)
{
    lsamp__v3 base = lsamp__v3_load(m->diffuse);
    float sum = 0.0f;
    uint32_t i;

    if (m->kind == LSAMP_MATERIAL_METAL_ROUGH) {
        s->alpha = m->roughness * m->roughness > 0.002f ? m->roughness * m->roughness : 0.002f;
        s->f0 = lsamp__v3_make(0.04f, 0.04f, 0.04f);
        s->f0 = lsamp__v3_madd(lsamp__v3_scale(s->f0, 1.0f - m->metallic), base, m->metallic);
        s->diffuse = lsamp__v3_scale(base, 1.0f - m->metallic);
        s->lobe_count = 1;
        s->lobe_share[0] = sum = lsamp__mean3(lsamp__schlick(s->f0, s->to_eye.z));
    } else if (m->kind == LSAMP_MATERIAL_PHONG) {
        float norm = (m->exponent + 2.0f) / (2.0f * LSAMP__PI);
        sum = lsamp__add_lobe(s, lsamp__v3_make(-1.0f, -1.0f, 1.0f), m->exponent,
                              lsamp__v3_scale(lsamp__v3_load(m->specular), norm));
    } else if (m->kind == LSAMP_MATERIAL_LAFORTUNE) {
        for (i = 0; i < m->lobe_count; i++)
            sum += lsamp__add_lobe(s, lsamp__v3_load(m->lobes[i].axis), m->lobes[i].exponent,
                                   lsamp__v3_load(m->lobes[i].scale));
    }
    return sum;
}

static void lsamp__surface_init(lsamp__surface *s, const lsamp_material *m, lsamp__v3 n, const float *tangent,
                                lsamp__v3 to_eye)
{
    lsamp__v3 t = tangent ? lsamp__v3_load(tangent) : lsamp__v3_make(0.0f, 0.0f, 0.0f);
    float specular, diffuse;
    uint32_t i;

    s->n = lsamp__v3_normalize(n);
    t = lsamp__v3_madd(t, s->n, -lsamp__v3_dot(t, s->n));
    if (lsamp__v3_dot(t, t) > 1e-6f) {
        s->t = lsamp__v3_normalize(t);
        s->b = lsamp__v3_cross(s->n, s->t);
    } else {
        lsamp__v3_basis(s->n, &s->t, &s->b);
    }
    s->to_eye = lsamp__to_axes(s, lsamp__v3_normalize(to_eye));
    if (s->to_eye.z < 1e-3f) {       /* the eye may be below the horizon of a normal that was interpolated */
        s->to_eye.z = 1e-3f;
        s->to_eye = lsamp__v3_normalize(s->to_eye);
    }
    if (s->to_eye.z > 1.0f) s->to_eye.z = 1.0f;
    s->diffuse = lsamp__v3_load(m->diffuse);
    s->alpha = 0.0f;
    s->lobe_count = 0;
    specular = lsamp__specular_init(s, m);
    for (i = 0; i < s->lobe_count; i++) s->lobe_share[i] /= specular;
    diffuse = lsamp__mean3(s->diffuse);
    s->black = !(diffuse + specular > 0.0f);
    s->diffuse_share = s->black ? 1.0f : diffuse / (diffuse + specular);
    s->peak = s->diffuse_share * (1.0f / LSAMP__PI);
    for (i = 0; i < s->lobe_count; i++) {
        float lobe = s->alpha > 0.0f ? 0.25f / (LSAMP__PI * s->alpha * s->alpha)
                                     : (s->lobes[i].exponent + 1.0f) / (2.0f * LSAMP__PI);
        s->peak += (1.0f - s->diffuse_share) * s->lobe_share[i] * lobe;
    }
}

/* Evaluates GGX with Smith's height-correlated shadowing (Heitz, JCGT 3(2), 2014). 1 - nh^2 is computed as
   hx^2 + hy^2, which keeps the digits of narrow peaks. The density is that of visible normals. */
static void lsamp__ggx_response(const lsamp__surface *s, lsamp__v3 wi, lsamp__response *r)
{
    lsamp__v3 h = lsamp__v3_normalize(lsamp__v3_add(s->to_eye, wi)), f;
    float a2 = s->alpha * s->alpha, q = h.x * h.x + h.y * h.y + a2 * h.z * h.z, d = a2 / (LSAMP__PI * q * q);
    float go = sqrtf(a2 + (1.0f - a2) * s->to_eye.z * s->to_eye.z);
    float gi = sqrtf(a2 + (1.0f - a2) * wi.z * wi.z);
    float vh = lsamp__v3_dot(s->to_eye, h);

    vh = vh > 0.0f ? vh < 1.0f ? vh : 1.0f : 0.0f;
    f = lsamp__schlick(s->f0, vh);
    r->specular = lsamp__v3_scale(f, 0.5f * d / (wi.z * go + s->to_eye.z * gi));
    r->diffuse = lsamp__v3_mul(r->diffuse, lsamp__v3_make(1.0f - f.x, 1.0f - f.y, 1.0f - f.z));
    r->specular_pdf = 0.5f * d / (s->to_eye.z + go);
}

static lsamp__response lsamp__brdf_response(const lsamp__surface *s, lsamp__v3 wi)
{
    lsamp__response r;
    uint32_t i;

    memset(&r, 0, sizeof r);
    if (!(wi.z > 0.0f)) return r;
    r.diffuse = lsamp__v3_scale(s->diffuse, 1.0f / LSAMP__PI);
    r.diffuse_pdf = wi.z * (1.0f / LSAMP__PI);
    if (s->lobe_count && s->alpha > 0.0f) {
        lsamp__ggx_response(s, wi, &r);
        return r;
    }
    for (i = 0; i < s->lobe_count; i++) {
        const lsamp__cosine_lobe *lobe = &s->lobes[i];
        float c = lsamp__v3_dot(lobe->axis, wi);
        if (!(c > 0.0f)) continue;
        c = lsamp__pow(c, lobe->exponent);
        r.specular = lsamp__v3_madd(r.specular, lobe->scale, c);
        r.specular_pdf += s->lobe_share[i] * c * (lobe->exponent + 1.0f) / (2.0f * LSAMP__PI);
    }
    return r;
}

static float lsamp__brdf_pdf(const lsamp__surface *s, const lsamp__response *r)
{
    return s->diffuse_share * r->diffuse_pdf + (1.0f - s->diffuse_share) * r->specular_pdf;
}

/* Draws a visible normal by spherical caps: Dupuy and Benyoub, "Sampling visible GGX normals with spherical
   caps", 2023. */
static lsamp__v3 lsamp__ggx_draw(const lsamp__surface *s, float u, float v)
{
    float a = s->alpha, z, r;
    float sn, cs, d;
    lsamp__v3 o = lsamp__v3_normalize(lsamp__v3_make(s->to_eye.x * a, s->to_eye.y * a, s->to_eye.z)), h;

    z = (1.0f - u) * (1.0f + o.z) - o.z;
    r = lsamp__safe_sqrt(1.0f - z * z);
    lsamp__sincos(2.0f * LSAMP__PI * v, &sn, &cs);
    h = lsamp__v3_add(lsamp__v3_make(r * cs, r * sn, z), o);
    h = lsamp__v3_normalize(lsamp__v3_make(h.x * a, h.y * a, h.z));
    d = 2.0f * lsamp__v3_dot(s->to_eye, h);
    return lsamp__v3_normalize(lsamp__v3_sub(lsamp__v3_scale(h, d), s->to_eye));
}

static lsamp__v3 lsamp__lobe_draw(const lsamp__cosine_lobe *lobe, float u, float v)
{
    lsamp__v3 t, b;
    float c = lsamp__pow(1.0f - u, 1.0f / (lobe->exponent + 1.0f)), r = lsamp__safe_sqrt(1.0f - c * c), sn,
          cs;
    lsamp__v3_basis(lobe->axis, &t, &b);
    lsamp__sincos(2.0f * LSAMP__PI * v, &sn, &cs);
    return lsamp__from_axes(t, b, lobe->axis, lsamp__v3_make(r * cs, r * sn, c));
}

/* Draws wi along the surface's axes. u picks the lobe and is then stretched over [0, 1) again, by which it
   stays stratified. */
static lsamp__v3 lsamp__brdf_draw(const lsamp__surface *s, float diffuse_share, float u, float v)
{
    uint32_t i = 0;
    if (u < diffuse_share || s->lobe_count == 0) {
        float x, y;
        lsamp__concentric(diffuse_share > 0.0f ? lsamp__clamp_unit(u / diffuse_share) : u, v, &x, &y);
        return lsamp__v3_make(x, y, lsamp__safe_sqrt(1.0f - x * x - y * y));
    }
    u = (u - diffuse_share) / (1.0f - diffuse_share);
    if (s->alpha > 0.0f) return lsamp__ggx_draw(s, lsamp__clamp_unit(u), v);
    for (; i + 1u < s->lobe_count && u >= s->lobe_share[i]; i++) u -= s->lobe_share[i];
    return lsamp__lobe_draw(&s->lobes[i], lsamp__clamp_unit(u / s->lobe_share[i]), v);
}

static lsamp_result lsamp__brdf_prepare(lsamp__surface *s, const lsamp_material *m, const float *normal,
                                        const float *tangent, const float *to_eye)
{
    lsamp__fault fault;          /* stays here, since these calls have no log */

    if (!m || !normal || !to_eye) return LSAMP_ERR_ARGUMENT;
    if (!lsamp__is_unit(normal) || !lsamp__is_unit(to_eye) || (tangent && !lsamp__is_unit(tangent)) ||
        !lsamp__material_valid(m, &fault))
        return LSAMP_ERR_INPUT;
    lsamp__surface_init(s, m, lsamp__v3_load(normal), tangent, lsamp__v3_load(to_eye));
    return LSAMP_OK;
}

/* Writes f and the density for wi, which is along the surface's axes. */
static void lsamp__brdf_result(const lsamp__surface *s, lsamp__v3 wi, float *f, float *pdf)
{
    lsamp__response r = lsamp__brdf_response(s, wi);
    lsamp__v3_store(f, lsamp__v3_add(r.diffuse, r.specular));
    *pdf = s->black ? 0.0f : lsamp__brdf_pdf(s, &r);
}

LSAMP_DEF lsamp_result lsamp_brdf_eval(const lsamp_material *material, const float normal[3],
                                       const float tangent[3], const float to_eye[3],
                                       const float direction[3],
                                       float f[3], float *pdf)
{
    lsamp__surface s;
    lsamp_result result = lsamp__brdf_prepare(&s, material, normal, tangent, to_eye);

    if (result != LSAMP_OK) return result;
    if (!direction || !f || !pdf) return LSAMP_ERR_ARGUMENT;
    if (!lsamp__is_unit(direction)) return LSAMP_ERR_INPUT;
    lsamp__brdf_result(&s, lsamp__to_axes(&s, lsamp__v3_normalize(lsamp__v3_load(direction))), f, pdf);
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_brdf_sample(const lsamp_material *material, const float normal[3],
                                         const float tangent[3], const float to_eye[3], const float u[2],
                                         float direction[3], float f[3], float *pdf)
{
    lsamp__surface s;
    lsamp__v3 w;
    lsamp_result result = lsamp__brdf_prepare(&s, material, normal, tangent, to_eye);

    if (result != LSAMP_OK) return result;
    if (!u || !direction || !f || !pdf) return LSAMP_ERR_ARGUMENT;
    if (!lsamp__in(u[0], 0.0f, LSAMP__BELOW_1) || !lsamp__in(u[1], 0.0f, LSAMP__BELOW_1))
        return LSAMP_ERR_INPUT;
    w = lsamp__brdf_draw(&s, s.diffuse_share, u[0], u[1]);
    lsamp__brdf_result(&s, w, f, pdf);
    lsamp__v3_store(direction, *pdf > 0.0f ? lsamp__from_axes(s.t, s.b, s.n, w) : s.n);
    return LSAMP_OK;
}

/* ==== src/lightsampling/curve.h ==== */

/* ---- curve: an emissive mesh as small pieces along a space-filling curve ---- */

typedef struct lsamp__piece {       /* a triangle, or a part of one */
    double   end;                   /* the share of all area that this piece and those before it have */
    uint64_t key;                   /* the place on the curve; the lowest 31 bits number the pieces, so that
                                       no two keys are equal */
    float    v[9], normal[3];
} lsamp__piece;

typedef struct lsamp__curve {       /* an emissive mesh */
    lsamp__piece *pieces;           /* in the order of the curve */
    float        *locations;        /* places for maps, four floats each */
    double        area;
    uint32_t      count, places;    /* of pieces; of locations */
} lsamp__curve;

static uint32_t lsamp__place_count(const lsamp_light_desc *d)
{
    return d->place_count ? d->place_count : 1024u;
}

/* Returns the most pieces that a mesh can be cut into. A triangle that is halved until its pieces are at most
   area / (2 places) gives fewer than 2 x 2 places x its share of the area, or is one piece. */
static size_t lsamp__most_pieces(const lsamp_light_desc *d)
{
    return lsamp__triangle_count(d->mesh) + 4u * (size_t)lsamp__place_count(d) + 1u;
}

static size_t lsamp__curve_size(const lsamp_light_desc *d)
{
    size_t bytes;
    if (!lsamp__mul_size(lsamp__most_pieces(d), sizeof(lsamp__piece), &bytes) ||
        !lsamp__add_size(bytes, 16u * (size_t)lsamp__place_count(d) + 16u + sizeof(lsamp__curve), &bytes))
        return 0;
    return bytes & ~(size_t)15u;
}

static lsamp__v3 lsamp__piece_corner(const float *v, uint32_t i) { return lsamp__v3_load(v + 3u * (i % 3u)); }

/* Returns a vector along the normal of a triangle, of twice its area. */
static lsamp__v3 lsamp__cross_of(const float *v)
{
    lsamp__v3 a = lsamp__piece_corner(v, 0);
    return lsamp__v3_cross(lsamp__v3_sub(lsamp__piece_corner(v, 1), a),
                           lsamp__v3_sub(lsamp__piece_corner(v, 2), a));
}

static double lsamp__area_of(const float *v)
{
    double area = 0.5 * (double)lsamp__v3_length(lsamp__cross_of(v));
    return area > 0.0 && area < 1e30 ? area : 0.0;
}

static void lsamp__load_triangle(const lsamp_mesh *m, size_t t, float v[9])
{
    uint32_t scratch[3], k;
    const uint32_t *c = lsamp__corners(m, t, scratch);
    for (k = 0; k < 3; k++) lsamp__v3_store(v + 3u * k, lsamp__vertex(m, c[k]));
}

/* Halves a triangle across its longest edge `levels` times; the bits of number choose the halves. */
static void lsamp__cut_piece(float v[9], uint32_t levels, uint32_t number)
{
    uint32_t bit, i, edge, k;
    for (bit = 0; bit < levels; bit++) {
        float longest = -1.0f;
        for (edge = i = 0; i < 3u; i++) {
            lsamp__v3 d = lsamp__v3_sub(lsamp__piece_corner(v, i + 1u), lsamp__piece_corner(v, i));
            if (lsamp__v3_dot(d, d) > longest) {
                longest = lsamp__v3_dot(d, d);
                edge = i;
            }
        }
        i = (edge + 1u) % 3u;
        for (k = 0; k < 3u; k++) {
            float middle = 0.5f * (v[3u * edge + k] + v[3u * i + k]);
            v[3u * (number >> bit & 1u ? edge : i) + k] = middle;
        }
    }
}

/* Returns the place of a piece on the curve: pieces that face the same way lie together, so that the sides of
   a thin plate do not mix; among them runs a Hilbert curve. */
static uint64_t lsamp__piece_key(const lsamp__piece *p, lsamp__v3 low, float size, uint32_t number)
{
    float n[3], middle[3];
    uint32_t axis = 0, cell[3], k;
    memcpy(n, p->normal, sizeof n);
    for (k = 1; k < 3u; k++)
        if (fabsf(n[k]) > fabsf(n[axis])) axis = k;
    lsamp__v3_store(middle,
                    lsamp__v3_add(lsamp__v3_add(lsamp__piece_corner(p->v, 0), lsamp__piece_corner(p->v, 1)),
                                  lsamp__piece_corner(p->v, 2)));
    lsamp__v3_store(middle, lsamp__v3_sub(lsamp__v3_scale(lsamp__v3_load(middle), 1.0f / 3.0f), low));
    for (k = 0; k < 3u; k++) {
        float x = middle[k] / size * 1024.0f;
        cell[k] = x > 0.0f ? x < 1023.0f ? (uint32_t)x : 1023u : 0u;
    }
    return (uint64_t)(2u * axis + (n[axis] < 0.0f)) << 61 |
           (uint64_t)lsamp__hilbert_index(cell, 10, 3) << 31 | number;
}

/* Sorts pieces by key. Heap sort needs no memory and gives the same everywhere. */
static void lsamp__sort_pieces(lsamp__piece *p, size_t count)
{
    size_t built = count / 2, end = count, at, child;
    while (end > 1) {
        lsamp__piece moved;
        if (built > 0) {
            moved = p[--built];
        } else {
            moved = p[--end];
            p[end] = p[0];
        }
        for (at = built; (child = 2 * at + 1) < end; at = child) {
            if (child + 1 < end && p[child].key < p[child + 1].key) child++;
            if (p[child].key <= moved.key) break;
            p[at] = p[child];
        }
        p[at] = moved;
    }
}

static const lsamp__piece *lsamp__find_piece(const lsamp__curve *c, double x)
{
    size_t low = 0, high = c->count - 1u;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (c->pieces[middle].end > x) high = middle;
        else low = middle + 1;
    }
    return &c->pieces[low];
}

static void lsamp__curve_point(const lsamp__curve *c, const float x[3], float position[3], float normal[3],
                               float *area)
{
    const lsamp__piece *p = lsamp__find_piece(c, (double)x[0]);
    float root = sqrtf(x[1]);
    lsamp__v3 q = lsamp__v3_scale(lsamp__piece_corner(p->v, 0), 1.0f - root);
    q = lsamp__v3_madd(q, lsamp__piece_corner(p->v, 1), root * (1.0f - x[2]));
    lsamp__v3_store(position, lsamp__v3_madd(q, lsamp__piece_corner(p->v, 2), root * x[2]));
    memcpy(normal, p->normal, sizeof p->normal);
    *area = (float)c->area;
}

/* Returns the area of the triangles that emit, and writes their bounds. */
static double lsamp__survey_mesh(const lsamp_mesh *m, lsamp__v3 *low, float *size)
{
    lsamp__v3 high = lsamp__v3_make(-1e30f, -1e30f, -1e30f), d;
    size_t t, count = lsamp__triangle_count(m);
    double sum = 0.0;
    float v[9];
    uint32_t k;
    *low = lsamp__v3_make(1e30f, 1e30f, 1e30f);
    for (t = 0; t < count; t++) {
        double area;
        lsamp__load_triangle(m, t, v);
        area = lsamp__area_of(v);
        sum += area;
        for (k = 0; k < 3u && area > 0.0; k++) {
            *low = lsamp__v3_min(*low, lsamp__piece_corner(v, k));
            high = lsamp__v3_max(high, lsamp__piece_corner(v, k));
        }
    }
    d = lsamp__v3_sub(high, *low);
    *size = d.x > d.y ? d.x : d.y;
    if (d.z > *size) *size = d.z;
    return sum;
}

static void lsamp__curve_cut(lsamp__curve *c, const lsamp_mesh *m, double most, lsamp__v3 low, float size)
{
    size_t t, count = lsamp__triangle_count(m);
    for (t = 0; t < count; t++) {
        float v[9];
        double area;
        uint32_t levels = 0, i;
        lsamp__load_triangle(m, t, v);
        area = lsamp__area_of(v);
        if (!(area > 0.0)) continue;
        while (area > most) {
            area *= 0.5;
            levels++;
        }
        for (i = 0; i >> levels == 0; i++) {
            lsamp__piece *p = &c->pieces[c->count];
            memcpy(p->v, v, sizeof v);
            lsamp__cut_piece(p->v, levels, i);
            lsamp__v3_store(p->normal, lsamp__v3_normalize(lsamp__cross_of(v)));
            p->end = area;
            p->key = lsamp__piece_key(p, low, size, c->count);
            c->count++;
        }
    }
}

static lsamp_result lsamp__curve_build(const lsamp_light_desc *d, void *memory, lsamp__curve **out)
{
    lsamp__curve *c = (lsamp__curve *)memory;
    lsamp__v3 low;
    float size;
    double sum = 0.0;
    uint32_t i;
    c->pieces = (lsamp__piece *)(void *)((char *)memory + ((sizeof *c + 15u) & ~(size_t)15u));
    c->locations = (float *)(void *)(c->pieces + lsamp__most_pieces(d));
    c->places = lsamp__place_count(d);
    c->count = 0;
    c->area = lsamp__survey_mesh(d->mesh, &low, &size);
    if (!(c->area > 0.0 && size > 0.0f && lsamp__finite(size))) return LSAMP_ERR_INPUT;
    lsamp__curve_cut(c, d->mesh, c->area / (2.0 * (double)c->places), low, size);
    lsamp__sort_pieces(c->pieces, c->count);
    for (i = 0; i < c->count; i++) {
        sum += c->pieces[i].end;
        c->pieces[i].end = sum / c->area;
    }
    for (i = 0; i < c->places; i++) {
        const lsamp__piece *p = lsamp__find_piece(c, ((double)i + 0.5) / (double)c->places);
        lsamp__v3 q = lsamp__v3_add(lsamp__v3_add(lsamp__piece_corner(p->v, 0), lsamp__piece_corner(p->v, 1)),
                                    lsamp__piece_corner(p->v, 2));
        q = lsamp__v3_madd(lsamp__v3_scale(q, 1.0f / 3.0f), lsamp__v3_load(p->normal), d->radius);
        lsamp__v3_store(c->locations + 4u * (size_t)i, q);
        c->locations[4u * (size_t)i + 3u] = 1.0f;
    }
    *out = c;
    return LSAMP_OK;
}

/* ==== src/lightsampling/emitter.h ==== */

/* ---- emitter: a light, its texels, and what leaves a point of it ---- */

struct lsamp_light {
    lsamp_light_desc desc;       /* texels is NULL, or the frame at desc.time with bad channels as 0 */
    const double *edges;         /* environment: the cosines of the height + 1 edges of rows */
    lsamp__cdf2   cdf;           /* over the texels; unused without texels */
    const uint16_t *guide;       /* for lsamp__invert_sums: of the rows, then of the texels of each row */
    lsamp__v3     origin;
    lsamp__v3     n;             /* the normal of the side that emits; line: its axis; sun: towards it; spot:
                                    out of the lamp */
    lsamp__v3     ex, ey;        /* rectangle: vectors whose dot products with a point give its x and y; disc:
                                    unit axes in its plane */
    lsamp__v3     radiance;
    lsamp__v3     tint;          /* its dot product with a texel is the texel's density relative to uniform
                                    coordinates; of an environment per solid angle */
    float         lx, ly, area;  /* lengths of the edges; area of the shape */
    float         cos_cone;      /* spot: the cosine of the half angle */
    float         turn;          /* environment: rotation / (2 pi) */
    int           orthogonal;    /* rectangle: its edges are at right angles */
    float         location[4];   /* point and spot: the only location of their domain */
    const lsamp__curve *curve;   /* mesh: its pieces; desc.kind is CALLBACK then, as it is of a surface */
    int           round;         /* columns of texels go round */
};

typedef struct lsamp__aim {      /* a light as one point sees it, which all samples of the point share */
    const lsamp_light *light;
    lsamp__v3 p;                 /* the point */
    lsamp__v3 axis;              /* sphere: unit, to the centre; line: unit, from the line to p */
    float distance;              /* sphere: to the centre; line: to its axis */
    float spread;                /* sphere: 1 - cos of the cone that it fills; line: the largest sine, of the
                                    angle about the axis, that p sees */
    float solid_pdf;             /* above 0: points are drawn evenly by solid angle, with this density */
    float solid;                 /* the solid angle that p sees; exact only for spheres and large
                                    rectangles */
    float x0, x1, y0, y1;        /* rectangle: its sides as seen from p, along its edges */
    float z;                     /* rectangle: the distance of its plane from p, with a sign */
    float b0, b1, k;             /* rectangle: what Urena et al. 2013, "An area-preserving parametrization for
                                    spherical rectangles", call so */
} lsamp__aim;

/* Says whether a light has one direction only at each point. */
static int lsamp__is_delta(const lsamp_light *l)
{
    return l->desc.kind == LSAMP_LIGHT_SUN || l->desc.kind == LSAMP_LIGHT_POINT ||
           l->desc.kind == LSAMP_LIGHT_SPOT;
}

static lsamp__v3 lsamp__texel_radiance(const lsamp_light *l, uint32_t x, uint32_t y)
{
    const float *t = l->desc.texels;
    return t ? lsamp__v3_load(t + 3u * ((size_t)y * l->desc.width + x)) : lsamp__v3_make(1.0f, 1.0f, 1.0f);
}

/* Returns which of count equal parts of 0..1 x falls into. */
static uint32_t lsamp__cell_of(float x, uint32_t count)
{
    uint32_t i = (uint32_t)((double)x * count);
    return i < count ? i : count - 1u;
}

/* Returns the texel before or after x, y, by dx and dy of -1..1: beyond an edge the last one, or that of the
   other side where columns go round. */
static lsamp__v3 lsamp__texel_beside(const lsamp_light *l, uint32_t x, uint32_t y, int dx, int dy)
{
    const uint32_t w = l->desc.width, h = l->desc.height;
    if (dx < 0) x = x ? x - 1u : l->round ? w - 1u : 0u;
    if (dx > 0) x = x + 1u < w ? x + 1u : l->round ? 0u : x;
    if (dy < 0 && y) y--;
    if (dy > 0 && y + 1u < h) y++;
    return lsamp__texel_radiance(l, x, y);
}

/* Returns the mean of L over texel x, y. Linear between the centres a, b, c, it is (a + 6 b + c) / 8. */
static lsamp__v3 lsamp__texel_mean(const lsamp_light *l, uint32_t x, uint32_t y)
{
    static const float weight[3] = { 0.125f, 0.75f, 0.125f };
    lsamp__v3 sum = lsamp__v3_make(0.0f, 0.0f, 0.0f);
    int dx, dy;
    if (l->desc.filter != LSAMP_TEXELS_LINEAR) return lsamp__texel_radiance(l, x, y);
    for (dy = -1; dy <= 1; dy++)
        for (dx = -1; dx <= 1; dx++)
            sum = lsamp__v3_madd(sum, lsamp__texel_beside(l, x, y, dx, dy), weight[dx + 1] * weight[dy + 1]);
    return sum;
}

/* Returns L at x, y. */
static lsamp__v3 lsamp__texel_at(const lsamp_light *l, float x, float y)
{
    const uint32_t i = lsamp__cell_of(x, l->desc.width), j = lsamp__cell_of(y, l->desc.height);
    float fx, fy;
    int dx, dy;
    lsamp__v3 a, b;

    if (l->desc.filter != LSAMP_TEXELS_LINEAR) return lsamp__texel_radiance(l, i, j);
    fx = x * (float)l->desc.width - ((float)i + 0.5f);      /* from the centre, -0.5..0.5 */
    fy = y * (float)l->desc.height - ((float)j + 0.5f);
    dx = fx < 0.0f ? -1 : 1;
    dy = fy < 0.0f ? -1 : 1;
    fx = fabsf(fx);
    fy = fabsf(fy);
    a = lsamp__v3_scale(lsamp__texel_radiance(l, i, j), 1.0f - fx);
    a = lsamp__v3_madd(a, lsamp__texel_beside(l, i, j, dx, 0), fx);
    b = lsamp__v3_scale(lsamp__texel_beside(l, i, j, 0, dy), 1.0f - fx);
    b = lsamp__v3_madd(b, lsamp__texel_beside(l, i, j, dx, dy), fx);
    return lsamp__v3_madd(lsamp__v3_scale(a, 1.0f - fy), b, fy);
}

/* Returns the density of the coordinates that lsamp__pick_point draws, relative to uniform ones. */
static float lsamp__texel_density(const lsamp_light *l, float x, float y)
{
    if (!l->desc.texels) return 1.0f;
    return lsamp__v3_dot(lsamp__texel_mean(l, lsamp__cell_of(x, l->desc.width),
                                           lsamp__cell_of(y, l->desc.height)), l->tint);
}

/* Returns the cell of a cdf that u falls into, and writes how far inside of the cell. guide[b] is the cell
   that b / count of the total falls into, so that the search begins a step or two from its end, in the same
   cache line. The last loops correct rounding at the ends of a bucket, and step out of cells of weight 0. */
static uint32_t lsamp__invert_sums(const double *sums, const uint16_t *guide, uint32_t count, float u,
                                   float *fraction)
{
    double x = (double)u * sums[count], f;
    uint32_t bucket = lsamp__cell_of(u, count), lo = guide[bucket],
             hi = bucket + 1u < count ? guide[bucket + 1u] + 1u : count;
    while (hi - lo > 1u) {
        uint32_t mid = lo + (hi - lo) / 2u;
        if (sums[mid] <= x) lo = mid;
        else hi = mid;
    }
    while (lo + 1u < count && sums[lo + 1u] <= x) lo++;
    while (lo > 0 && (sums[lo] > x || !(sums[lo + 1u] > sums[lo]))) lo--;
    f = (x - sums[lo]) / (sums[lo + 1u] - sums[lo]);
    *fraction = lsamp__clamp_unit((float)f);
    return lo;
}

/* Makes the guide of lsamp__invert_sums. */
static void lsamp__guide_build(const double *sums, uint16_t *guide, uint32_t count)
{
    uint32_t b, i = 0;
    for (b = 0; b < count; b++) {
        double x = sums[count] * b / count;
        while (i + 1u < count && sums[i + 1u] <= x) i++;
        guide[b] = (uint16_t)i;
    }
}

/* Writes the texel that u picks, and which point inside of the texel. Returns 0 if all texels are black. */
static int lsamp__pick_cell(const lsamp_light *l, const float *u, uint32_t *x, uint32_t *y, float *fx,
                            float *fy)
{
    uint32_t w = l->desc.width;
    if (!(lsamp__cdf2_total(&l->cdf) > 0.0)) return 0;
    *y = lsamp__invert_sums(l->cdf.rows, l->guide, l->desc.height, u[1], fy);
    *x = lsamp__invert_sums(l->cdf.sums + (size_t)*y * (w + 1u), l->guide + l->desc.height + (size_t)*y * w,
                            w, u[0], fx);
    return 1;
}

/* Draws coordinates in proportion to the texels. */
static void lsamp__pick_point(const lsamp_light *l, const float *u, float *x, float *y)
{
    uint32_t i, j;
    *x = u[0];
    *y = u[1];
    if (!l->desc.texels || !lsamp__pick_cell(l, u, &i, &j, x, y)) return;
    *x = lsamp__clamp_unit(((float)i + *x) / (float)l->desc.width);
    *y = lsamp__clamp_unit(((float)j + *y) / (float)l->desc.height);
}

/* Writes the radiance that leaves the point out->coords along away: L times the texel and the angular
   factors. Returns 0 if it is black. */
static int lsamp__emit(const lsamp_light *l, lsamp__v3 texel, float cosine, lsamp__v3 away,
                       lsamp_emission *out)
{
    lsamp__v3 c = lsamp__v3_mul(l->radiance, texel);
    if (l->desc.cosine_power > 0.0f) c = lsamp__v3_scale(c, lsamp__pow(cosine, l->desc.cosine_power));
    if (l->desc.emission_fn) {
        float w[3], rgb[3] = { 0.0f, 0.0f, 0.0f };
        int i;
        lsamp__v3_store(w, away);
        l->desc.emission_fn(l->desc.user, l->desc.time, out->coords, w, rgb);
        for (i = 0; i < 3; i++)
            if (!lsamp__finite(rgb[i]) || rgb[i] < 0.0f) rgb[i] = 0.0f;
        c = lsamp__v3_mul(c, lsamp__v3_load(rgb));
    }
    lsamp__v3_store(out->radiance, c);
    return lsamp__v3_finite(c) && c.x + c.y + c.z > 0.0f;
}

/* Writes how p sees the point q of a light, which has the normal n (0: a volume) and the coordinates x, y.
   The density is a->solid_pdf; if that is 0, it is area_pdf, turned into a density per solid angle. Returns 0
   if no light of q reaches p. */
static int lsamp__emit_area(const lsamp__aim *a, lsamp__v3 q, lsamp__v3 n, float x, float y, float area_pdf,
                            lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    lsamp__v3 d = lsamp__v3_sub(q, a->p), w;
    float d2 = lsamp__v3_dot(d, d), distance = sqrtf(d2), cosine;

    if (!(distance > 0.0f) || !lsamp__finite(d2)) return 0;
    w = lsamp__v3_scale(d, 1.0f / distance);
    cosine = n.x != 0.0f || n.y != 0.0f || n.z != 0.0f ? -lsamp__v3_dot(n, w) : 1.0f;
    if (!(cosine > 1e-7f)) return 0;
    if (cosine > 1.0f) cosine = 1.0f;
    out->coords[0] = lsamp__clamp_unit(x);
    out->coords[1] = lsamp__clamp_unit(y);
    out->distance = distance;
    out->pdf = a->solid_pdf > 0.0f ? a->solid_pdf : area_pdf * d2 / cosine;
    lsamp__v3_store(out->direction, w);
    return lsamp__emit(l, lsamp__texel_at(l, x, y), cosine, lsamp__v3_scale(w, -1.0f), out);
}

/* ==== src/lightsampling/shapes.h ==== */

/* ---- shapes: a point of each shape drawn, and found along a ray ---- */

/* Writes how a point sees an environment in direction w, which lies in texel x, y at the coordinates u, v.
   Rows go by the cosines of their edges, so that solid angles are exact (T12). Returns 0 if the texel is
   black. */
static int lsamp__environment_found(const lsamp_light *l, uint32_t x, uint32_t y, float u, float v,
                                    lsamp__v3 w, lsamp_emission *out)
{
    lsamp__v3 mean = lsamp__texel_mean(l, x, y), texel = mean;

    if (l->desc.filter == LSAMP_TEXELS_LINEAR)
        texel = lsamp__texel_at(l, lsamp__clamp_unit(u), lsamp__clamp_unit(v));
    u -= l->turn;
    out->coords[0] = lsamp__clamp_unit(u - floorf(u));
    out->coords[1] = lsamp__clamp_unit(v);
    out->distance = LSAMP_INFINITY;
    out->pdf = lsamp__v3_dot(mean, l->tint);
    lsamp__v3_store(out->direction, w);
    return lsamp__emit(l, texel, 1.0f, w, out) && out->pdf > 0.0f;
}

static int lsamp__environment_draw(const lsamp_light *l, const float *u, lsamp_emission *out)
{
    float x, y, r;
    float sn, cs;
    float fx, fy;
    uint32_t i, j;

    if (!lsamp__pick_cell(l, u, &i, &j, &fx, &fy)) return 0;
    x = ((float)i + fx) / (float)l->desc.width;
    y = (float)(l->edges[j] + (l->edges[j + 1u] - l->edges[j]) * (double)fy);
    r = lsamp__safe_sqrt((1.0f - y) * (1.0f + y));
    lsamp__sincos(2.0f * LSAMP__PI * (x - l->turn - 0.5f), &sn, &cs);
    return lsamp__environment_found(l, i, j, x, lsamp__acos(y) / LSAMP__PI,
                                    lsamp__v3_make(r * cs, y, r * sn), out);
}

static int lsamp__environment_hit(const lsamp_light *l, lsamp__v3 w, lsamp_emission *out)
{
    float u = 0.5f + lsamp__atan2(w.z, w.x) / (2.0f * LSAMP__PI) + l->turn, v = lsamp__acos(w.y) / LSAMP__PI;
    u -= floorf(u);
    return lsamp__environment_found(l, lsamp__cell_of(u, l->desc.width), lsamp__cell_of(v, l->desc.height), u,
                                    v, w, out);
}

/* Prepares the sampling of a rectangle by solid angle: Urena, Fajardo and King, "An area-preserving
   parametrization for spherical rectangles", EGSR 2013. In floats this needs a solid angle that is not small;
   smaller rectangles are sampled by area, which is no worse there. */
static void lsamp__rectangle_aim(lsamp__aim *a)
{
    const lsamp_light *l = a->light;
    lsamp__v3 d = lsamp__v3_sub(l->origin, a->p);
    float n0, n1, n2, n3;
    float g0, g1, g2, g3;
    float z2;

    a->x0 = lsamp__v3_dot(d, l->ex) * l->lx;
    a->y0 = lsamp__v3_dot(d, l->ey) * l->ly;
    a->x1 = a->x0 + l->lx;
    a->y1 = a->y0 + l->ly;
    a->z = lsamp__v3_dot(d, l->n);   /* below 0: p is on the side that emits */
    z2 = a->z * a->z;
    n0 = -a->y0 / sqrtf(z2 + a->y0 * a->y0);
    n1 = a->x1 / sqrtf(z2 + a->x1 * a->x1);
    n2 = a->y1 / sqrtf(z2 + a->y1 * a->y1);
    n3 = -a->x0 / sqrtf(z2 + a->x0 * a->x0);
    g0 = lsamp__acos(-n0 * n1);
    g1 = lsamp__acos(-n1 * n2);
    g2 = lsamp__acos(-n2 * n3);
    g3 = lsamp__acos(-n3 * n0);
    a->b0 = n0;
    a->b1 = n2;
    a->k = 2.0f * LSAMP__PI - g2 - g3;
    a->solid = g0 + g1 - a->k;
    if (a->solid > 0.05f && lsamp__finite(a->solid)) a->solid_pdf = 1.0f / a->solid;
}

/* Returns the solid angle of a flat shape of this area and normal about d: right far away, at most 2 pi close
   by. */
static float lsamp__flat_solid(lsamp__v3 n, lsamp__v3 d, float area)
{
    float d2 = lsamp__v3_dot(d, d), cosine = fabsf(lsamp__v3_dot(n, d)) / sqrtf(d2 > 0.0f ? d2 : 1.0f);
    float near2 = area * (1.0f / (2.0f * LSAMP__PI));
    return area * (cosine * d2 + near2) / ((d2 + near2) * (d2 + near2));
}

static void lsamp__rectangle_pick(const lsamp__aim *a, const float *u, float *x, float *y)
{
    float au = u[0] * a->solid + a->k, sn, cs;
    float f, c, d;
    float xu, yv;
    float h0, h1, h;

    lsamp__sincos(au, &sn, &cs);
    f = (cs * a->b0 - a->b1) / sn;
    c = 1.0f / sqrtf(f * f + a->b0 * a->b0);
    c = f > 0.0f ? c : -c;
    c = c > -1.0f ? c < 1.0f ? c : 1.0f : -1.0f;
    xu = -(c * a->z) / sqrtf(1.0f - c * c > 1e-12f ? 1.0f - c * c : 1e-12f);
    xu = xu > a->x0 ? xu < a->x1 ? xu : a->x1 : a->x0;
    d = sqrtf(xu * xu + a->z * a->z);
    h0 = a->y0 / sqrtf(d * d + a->y0 * a->y0);
    h1 = a->y1 / sqrtf(d * d + a->y1 * a->y1);
    h = h0 + u[1] * (h1 - h0);
    yv = h * h < 1.0f - 1e-6f ? h * d / sqrtf(1.0f - h * h) : a->y1;
    *x = (xu - a->x0) / (a->x1 - a->x0);
    *y = (yv - a->y0) / (a->y1 - a->y0);
}

/* Computes the members of an aim, which depend on light and point alone. Returns 0 if the light does not
   reach p. */
static int lsamp__aim_at(lsamp__aim *a, const lsamp_light *l, lsamp__v3 p)
{
    lsamp__v3 d = lsamp__v3_sub(l->origin, p);
    float r = l->desc.radius, s;

    memset(a, 0, sizeof *a);
    a->light = l;
    a->p = p;
    switch (l->desc.kind) {
    case LSAMP_LIGHT_RECTANGLE:
        if (!(lsamp__v3_dot(l->n, d) < 0.0f)) return 0;
        if (l->orthogonal && !l->desc.texels) lsamp__rectangle_aim(a);
        if (a->solid_pdf > 0.0f) return 1;
        d = lsamp__v3_madd(d, lsamp__v3_add(lsamp__v3_load(l->desc.u), lsamp__v3_load(l->desc.v)), 0.5f);
        a->solid = lsamp__flat_solid(l->n, d, l->area);
        return 1;
    case LSAMP_LIGHT_DISC:
        a->solid = lsamp__flat_solid(l->n, d, l->area);
        return lsamp__v3_dot(l->n, d) < 0.0f;
    case LSAMP_LIGHT_SPHERE:
        a->distance = lsamp__v3_length(d);
        if (!(a->distance > r)) return 0;
        a->axis = lsamp__v3_scale(d, 1.0f / a->distance);
        s = (r / a->distance) * (r / a->distance);
        a->spread = s / (1.0f + sqrtf(1.0f - s));
        a->solid = 2.0f * LSAMP__PI * a->spread;
        if (!l->desc.texels && a->spread > 0.0f) a->solid_pdf = 1.0f / a->solid;
        return 1;
    case LSAMP_LIGHT_LINE:
        s = lsamp__v3_dot(d, l->n);
        d = lsamp__v3_sub(lsamp__v3_scale(l->n, s), d);
        a->distance = lsamp__v3_length(d);
        if (!(a->distance > r)) return 0;
        a->axis = lsamp__v3_scale(d, 1.0f / a->distance);
        a->spread = lsamp__safe_sqrt(1.0f - (r / a->distance) * (r / a->distance));
        d = lsamp__v3_make(a->distance, s, s + l->lx);   /* the line seen edge to edge: sines of its ends */
        a->solid = 2.0f * r / d.x * (d.z / sqrtf(d.x * d.x + d.z * d.z) - d.y / sqrtf(d.x * d.x + d.y * d.y));
        return 1;
    default:
        return 1;
    }
}

/* Returns the point A(x, y) of a shape that is flat or round; of a line, a point of its axis. */
static lsamp__v3 lsamp__shape_point(const lsamp_light *l, float x, float y)
{
    float dx, dy, sn, cs;
    float r = l->desc.radius;
    lsamp__v3 a, b;

    switch (l->desc.kind) {
    case LSAMP_LIGHT_LINE:
        return lsamp__v3_madd(l->origin, l->n, x * l->lx);
    case LSAMP_LIGHT_RECTANGLE:
        a = lsamp__v3_scale(lsamp__v3_load(l->desc.u), x);
        b = lsamp__v3_scale(lsamp__v3_load(l->desc.v), y);
        return lsamp__v3_add(l->origin, lsamp__v3_add(a, b));
    case LSAMP_LIGHT_DISC:
        lsamp__concentric(x, y, &dx, &dy);
        a = lsamp__v3_add(lsamp__v3_scale(l->ex, dx), lsamp__v3_scale(l->ey, dy));
        return lsamp__v3_madd(l->origin, a, r);
    case LSAMP_LIGHT_SPHERE:
        dy = 1.0f - 2.0f * y;
        dx = lsamp__safe_sqrt(1.0f - dy * dy);
        lsamp__sincos(2.0f * LSAMP__PI * (x - 0.5f), &sn, &cs);
        return lsamp__v3_madd(l->origin, lsamp__v3_make(dx * cs, dy, dx * sn), r);
    default:
        return l->origin;
    }
}

/* Writes how p sees a line's cylinder at x along the axis and at an angle about it, whose sine is given.
   Sines are spread evenly over the breadth that p sees, by which the lamp's own cosine drops out. Returns 0
   if no light reaches p. */
static int lsamp__line_at(const lsamp__aim *a, float x, float sine, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    float cosine = lsamp__safe_sqrt(1.0f - sine * sine);
    lsamp__v3 n = lsamp__v3_scale(a->axis, cosine), q;

    n = lsamp__v3_madd(n, lsamp__v3_cross(l->n, a->axis), sine);
    q = lsamp__v3_madd(lsamp__shape_point(l, x, 0.0f), n, l->desc.radius);
    return lsamp__emit_area(a, q, n, x, 0.0f, lsamp__texel_density(l, x, 0.0f) * cosine /
                                                  (2.0f * a->spread * l->desc.radius * l->lx), out);
}

static int lsamp__sphere_at(const lsamp__aim *a, lsamp__v3 n, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    float x = 0.5f + lsamp__atan2(n.z, n.x) / (2.0f * LSAMP__PI), y = 0.5f * (1.0f - n.y);
    x = lsamp__clamp_unit(x);
    y = lsamp__clamp_unit(y);
    return lsamp__emit_area(a, lsamp__v3_madd(l->origin, n, l->desc.radius), n, x, y,
                            lsamp__texel_density(l, x, y) / l->area, out);
}

static int lsamp__sphere_draw(const lsamp__aim *a, const float *u, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    float r = l->desc.radius;
    float x, y, sn, cs;
    float c, s2, along, reach;
    lsamp__v3 t, b, n;

    if (!(a->solid_pdf > 0.0f)) {
        lsamp__pick_point(l, u, &x, &y);
        n = lsamp__v3_sub(lsamp__shape_point(l, x, y), l->origin);
        return lsamp__sphere_at(a, lsamp__v3_normalize(n), out);
    }
    /* The direction lies in the cone about the axis; the normal where the ray meets the sphere follows from
       the law of sines. */
    c = u[0] * a->spread;
    s2 = c * (2.0f - c);
    c = 1.0f - c;
    reach = lsamp__safe_sqrt(r * r - a->distance * a->distance * s2);
    along = a->distance * s2 + c * reach;       /* from the centre towards p */
    x = lsamp__safe_sqrt(s2) * (a->distance * c - reach) / r;
    lsamp__sincos(2.0f * LSAMP__PI * u[1], &sn, &cs);
    lsamp__v3_basis(a->axis, &t, &b);
    n = lsamp__from_axes(t, b, a->axis, lsamp__v3_make(x * cs, x * sn, -along / r));
    return lsamp__sphere_at(a, lsamp__v3_normalize(n), out);
}

static int lsamp__delta_draw(const lsamp__aim *a, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    lsamp__v3 d = lsamp__v3_sub(l->origin, a->p), w = l->n;
    float distance = lsamp__v3_length(d), scale = 1.0f;

    out->pdf = 1.0f;
    out->distance = LSAMP_INFINITY;
    if (l->desc.kind != LSAMP_LIGHT_SUN) {
        if (!(distance > 0.0f) || !lsamp__finite(distance)) return 0;
        w = lsamp__v3_scale(d, 1.0f / distance);
        if (l->desc.kind == LSAMP_LIGHT_SPOT && -lsamp__v3_dot(w, l->n) < l->cos_cone) return 0;
        scale = 1.0f / (distance * distance);
        out->distance = distance;
    }
    lsamp__v3_store(out->direction, w);
    return lsamp__emit(l, lsamp__v3_make(scale, scale, scale), 1.0f, lsamp__v3_scale(w, -1.0f), out);
}

/* Writes the point of a surface at x, y, its normal, and d area / dx dy there. */
static void lsamp__surface_point(const lsamp_surface *s, float x, float y, float q[3], float n[3],
                                 float *area)
{
    const uint32_t columns = s->width - (s->round ? 0u : 1u), rows = s->height - 1u;
    const uint32_t i = lsamp__cell_of(x, columns), j = lsamp__cell_of(y, rows);
    const uint32_t next = i + 1u < s->width ? i + 1u : 0u;
    const float fx = x * (float)columns - (float)i, fy = y * (float)rows - (float)j;
    const float *row = s->points + 3u * (size_t)j * s->width, *after = row + 3u * (size_t)s->width;
    const lsamp__v3 a = lsamp__v3_load(row + 3u * (size_t)i), b = lsamp__v3_load(row + 3u * (size_t)next);
    const lsamp__v3 c = lsamp__v3_load(after + 3u * (size_t)i), d = lsamp__v3_load(after + 3u * (size_t)next);
    const lsamp__v3 top = lsamp__v3_sub(b, a), bottom = lsamp__v3_sub(d, c);
    const lsamp__v3 left = lsamp__v3_sub(c, a), right = lsamp__v3_sub(d, b);
    const lsamp__v3 along = lsamp__v3_madd(lsamp__v3_scale(top, 1.0f - fy), bottom, fy);
    const lsamp__v3 across = lsamp__v3_madd(lsamp__v3_scale(left, 1.0f - fx), right, fx);
    const lsamp__v3 normal = lsamp__v3_cross(lsamp__v3_scale(along, (float)columns),
                                             lsamp__v3_scale(across, (float)rows));
    lsamp__v3_store(q, lsamp__v3_madd(lsamp__v3_madd(a, top, fx), across, fy));
    lsamp__v3_store(n, normal);
    *area = lsamp__v3_length(normal);
}

static int lsamp__callback_draw(const lsamp__aim *a, const float *u, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    float q[3] = { 0.0f, 0.0f, 0.0f }, n[3] = { 0.0f, 0.0f, 0.0f };
    float area = 0.0f, x, y;

    lsamp__pick_point(l, u, &x, &y);
    out->coords[0] = x;
    out->coords[1] = y;
    out->coords[2] = l->desc.surface ? 0.0f : u[2];
    if (l->curve) lsamp__curve_point(l->curve, out->coords, q, n, &area);
    else if (l->desc.surface) lsamp__surface_point(l->desc.surface, x, y, q, n, &area);
    else l->desc.shape_fn(l->desc.user, l->desc.time, out->coords, q, n, &area);
    if (!lsamp__v3_finite(lsamp__v3_load(q)) || !lsamp__v3_finite(lsamp__v3_load(n)) ||
        !lsamp__finite(area) || !(area > 0.0f))
        return 0;
    return lsamp__emit_area(a, lsamp__v3_load(q), lsamp__v3_normalize(lsamp__v3_load(n)), x, y,
                            lsamp__texel_density(l, x, y) / area, out);
}

static int lsamp__emitter_draw(const lsamp__aim *a, const float *u, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    float x, y;

    memset(out, 0, sizeof *out);
    switch (l->desc.kind) {
    case LSAMP_LIGHT_RECTANGLE:
    case LSAMP_LIGHT_DISC:
        if (a->solid_pdf > 0.0f) lsamp__rectangle_pick(a, u, &x, &y);
        else lsamp__pick_point(l, u, &x, &y);
        return lsamp__emit_area(a, lsamp__shape_point(l, x, y), l->n, x, y,
                                lsamp__texel_density(l, x, y) / l->area, out);
    case LSAMP_LIGHT_SPHERE:
        return lsamp__sphere_draw(a, u, out);
    case LSAMP_LIGHT_LINE:
        lsamp__pick_point(l, u, &x, &y);
        return lsamp__line_at(a, x, (2.0f * u[1] - 1.0f) * a->spread, out);
    case LSAMP_LIGHT_CALLBACK:
        return lsamp__callback_draw(a, u, out);
    case LSAMP_LIGHT_SUN:
    case LSAMP_LIGHT_POINT:
    case LSAMP_LIGHT_SPOT:
        return lsamp__delta_draw(a, out);
    default:
        return lsamp__environment_draw(l, u, out);
    }
}

/* Finds where a ray meets a rectangle or disc. Returns 0 if the ray sees no light. */
static int lsamp__plane_hit(const lsamp__aim *a, lsamp__v3 w, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    lsamp__v3 d = lsamp__v3_sub(a->p, l->origin), q;
    float slope = -lsamp__v3_dot(l->n, w), height = lsamp__v3_dot(l->n, d), x, y;

    if (!(slope > 1e-7f) || !(height > 0.0f)) return 0;
    d = lsamp__v3_madd(d, w, height / slope);
    q = lsamp__v3_add(l->origin, d);
    x = lsamp__v3_dot(d, l->ex);
    y = lsamp__v3_dot(d, l->ey);
    if (l->desc.kind == LSAMP_LIGHT_DISC) {
        x /= l->desc.radius;
        y /= l->desc.radius;
        if (!(x * x + y * y < 1.0f)) return 0;
        lsamp__disc_square(x, y, &x, &y);
    } else if (!(x >= 0.0f && x < 1.0f && y >= 0.0f && y < 1.0f)) {
        return 0;
    }
    return lsamp__emit_area(a, q, l->n, x, y, lsamp__texel_density(l, x, y) / l->area, out);
}

/* Finds where a ray meets a sphere or line: the nearer root, measured from the foot of the perpendicular,
   which keeps its digits. Returns 0 if the ray sees no light. */
static int lsamp__round_hit(const lsamp__aim *a, lsamp__v3 w, lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    lsamp__v3 d = lsamp__v3_sub(l->origin, a->p), v = w, n;
    float r = l->desc.radius;
    float along, s, x, len2;

    if (l->desc.kind == LSAMP_LIGHT_LINE) {     /* across its axis, a line is a circle */
        d = lsamp__v3_scale(a->axis, -a->distance);
        v = lsamp__v3_madd(w, l->n, -lsamp__v3_dot(w, l->n));
    }
    len2 = lsamp__v3_dot(v, v);
    if (!(len2 > 1e-14f)) return 0;
    along = lsamp__v3_dot(d, v) / len2;
    n = lsamp__v3_sub(lsamp__v3_scale(v, along), d);
    s = r * r - lsamp__v3_dot(n, n);
    if (!(along > 0.0f) || !(s > 0.0f)) return 0;
    s = sqrtf(s / len2);
    n = lsamp__v3_scale(lsamp__v3_madd(n, v, -s), 1.0f / r);
    if (l->desc.kind == LSAMP_LIGHT_SPHERE) return lsamp__sphere_at(a, lsamp__v3_normalize(n), out);
    x = lsamp__v3_dot(lsamp__v3_madd(lsamp__v3_sub(a->p, l->origin), w, along - s), l->n) / l->lx;
    if (!(x >= 0.0f && x < 1.0f)) return 0;
    return lsamp__line_at(a, x, lsamp__v3_dot(n, lsamp__v3_cross(l->n, a->axis)), out);
}

static int lsamp__aim_hit(const lsamp__aim *a, lsamp__v3 w, lsamp_emission *out)
{
    memset(out, 0, sizeof *out);
    switch (a->light->desc.kind) {
    case LSAMP_LIGHT_RECTANGLE:
    case LSAMP_LIGHT_DISC:
        return lsamp__plane_hit(a, w, out);
    case LSAMP_LIGHT_SPHERE:
    case LSAMP_LIGHT_LINE:
        return lsamp__round_hit(a, w, out);
    case LSAMP_LIGHT_DEFAULT:
    case LSAMP_LIGHT_ENVIRONMENT:
        return lsamp__environment_hit(a->light, w, out);
    default:
        return 0;
    }
}

/* ==== src/lightsampling/emitter_build.h ==== */

/* ---- emitter: a desc checked, a light made of it, and public questions ---- */

/* Says whether a field lies within low..high; if not, logs so. log may be NULL. */
static int lsamp__field_valid(const lsamp__logger *log, const char *field, float value, float low, float high,
                              const char *wanted)
{
    if (lsamp__in(value, low, high)) return 1;
    if (log) lsamp__log_value(log, field, (double)value, wanted);
    return 0;
}

static int lsamp__field3_valid(const lsamp__logger *log, const char *field, const float *value, float low,
                               float high, const char *wanted)
{
    return lsamp__field_valid(log, field, value[0], low, high, wanted) &&
           lsamp__field_valid(log, field, value[1], low, high, wanted) &&
           lsamp__field_valid(log, field, value[2], low, high, wanted);
}

static int lsamp__count_valid(const lsamp__logger *log, const char *field, uint32_t value, uint32_t low,
                              uint32_t high, const char *wanted)
{
    if (value >= low && value <= high) return 1;
    if (log) lsamp__log_value(log, field, (double)value, wanted);
    return 0;
}

/* Logs that a field of this kind of light is set or missing against the rule. Returns 0. */
static int lsamp__light_refuse(const lsamp__logger *log, const char *field, const char *text)
{
    if (log) lsamp__log_text(log, field, text);
    return 0;
}

static int lsamp__direction_valid(const lsamp__logger *log, const lsamp_light_desc *d)
{
    if (lsamp__is_unit(d->direction)) return 1;
    if (log)
        lsamp__log_value(log, "the length of desc.direction",
                         (double)lsamp__v3_length(lsamp__v3_load(d->direction)), "1 (0.97..1.03)");
    return 0;
}

static int lsamp__texels_valid(const lsamp__logger *log, const lsamp_light_desc *d)
{
    if (d->texels)
        return lsamp__count_valid(log, "desc.width", d->width, 1, 65536, "1..65536 with texels") &&
               lsamp__count_valid(log, "desc.height", d->height, 1, d->kind == LSAMP_LIGHT_LINE ? 1 : 65536,
                                  d->kind == LSAMP_LIGHT_LINE ? "1 for a line" : "1..65536 with texels") &&
               lsamp__count_valid(log, "desc.frame_count", d->frame_count, 0, 1u << 24, "0 or 1..2^24");
    return lsamp__count_valid(log, "desc.width", d->width, 0, 0, "0 without texels") &&
           lsamp__count_valid(log, "desc.height", d->height, 0, 0, "0 without texels") &&
           lsamp__count_valid(log, "desc.frame_count", d->frame_count, 0, 1, "0 or 1 without texels");
}

/* Says whether the fields of a sun, point or spot are valid; if not, logs so. */
static int lsamp__delta_valid(const lsamp__logger *log, const lsamp_light_desc *d)
{
    if (d->texels) return lsamp__light_refuse(log, "desc.texels", "is set: sun, point and spot have none");
    if (d->emission_fn)
        return lsamp__light_refuse(log, "desc.emission_fn", "is set: sun, point and spot have none");
    if (d->kind == LSAMP_LIGHT_POINT) return 1;
    return lsamp__direction_valid(log, d) &&
           (d->kind == LSAMP_LIGHT_SUN || lsamp__field_valid(log, "desc.cone_half_angle", d->cone_half_angle,
                                                             5e-7f, 0.5f * LSAMP__PI, "5e-7..pi / 2"));
}

/* Says whether the fields of a shape that has an area are valid; if not, logs so. */
static int lsamp__shape_valid(const lsamp__logger *log, const lsamp_light_desc *d)
{
    const float big = 1e18f;
    lsamp__v3 n = lsamp__v3_cross(lsamp__v3_load(d->u), lsamp__v3_load(d->v));

    if (d->kind == LSAMP_LIGHT_RECTANGLE) {
        if (!lsamp__field3_valid(log, "desc.u", d->u, -big, big, "-1e18..1e18") ||
            !lsamp__field3_valid(log, "desc.v", d->v, -big, big, "-1e18..1e18"))
            return 0;
        if (lsamp__v3_finite(n) && lsamp__v3_length(n) > 0.0f && lsamp__finite(lsamp__v3_length(n))) return 1;
        return lsamp__light_refuse(log, "desc.u", "and desc.v span no area");
    }
    if (d->kind == LSAMP_LIGHT_LINE) {
        if (!lsamp__field3_valid(log, "desc.u", d->u, -big, big, "-1e18..1e18")) return 0;
        if (!(lsamp__v3_length(lsamp__v3_load(d->u)) > 0.0f))
            return lsamp__light_refuse(log, "desc.u", "has no length");
    }
    return (d->kind != LSAMP_LIGHT_DISC || lsamp__direction_valid(log, d)) &&
           lsamp__field_valid(log, "desc.radius", d->radius, 1e-18f, big, "1e-18..1e18");
}

/* Says whether a surface is valid. Its points may move from frame to frame: they are looked at when drawn. */
static int lsamp__surface_valid(const lsamp__logger *log, const lsamp_surface *s)
{
    if (!s) return lsamp__light_refuse(log, "desc.surface", "is NULL");
    if (!s->points) return lsamp__light_refuse(log, "desc.surface->points", "is NULL");
    return lsamp__count_valid(log, "desc.surface->width", s->width, 2, 4096, "2..4096") &&
           lsamp__count_valid(log, "desc.surface->height", s->height, 2, 4096, "2..4096");
}

/* Checks the fields that only a mesh has, and the mesh, whose faults are not those of the desc. */
static lsamp_result lsamp__mesh_light_check(const lsamp__logger *log, const lsamp_light_desc *d)
{
    lsamp_result result;
    if (d->texels) {
        (void)lsamp__light_refuse(log, "desc.texels", "is set: a mesh has none");
        return LSAMP_ERR_DESC;
    }
    result = lsamp__mesh_check(d->mesh, log);
    if (result != LSAMP_OK) return result;
    return lsamp__count_valid(log, "desc.place_count", d->place_count, 0, 1u << 24, "0 or 1..2^24") &&
                   lsamp__field_valid(log, "desc.radius", d->radius, 0.0f, 1e18f, "0..1e18")
               ? LSAMP_OK
               : LSAMP_ERR_DESC;
}

/* Says whether the fields of all kinds of light are valid, but for a mesh's. */
static int lsamp__fields_valid(const lsamp_light_desc *d, const lsamp__logger *log)
{
    const float big = 1e18f;

    if ((unsigned)d->kind >= (unsigned)LSAMP_LIGHT_COUNT) {
        if (log) lsamp__log_value(log, "desc.kind", (double)d->kind, "a LSAMP_LIGHT_...");
        return 0;
    }
    if (!lsamp__field3_valid(log, "desc.radiance", d->radiance, 0.0f, 1e30f, "0..1e30") ||
        !lsamp__field_valid(log, "desc.time", d->time, -1e9f, 1e9f, "-1e9..1e9") ||
        !lsamp__field_valid(log, "desc.cosine_power", d->cosine_power, 0.0f, 1e5f, "0..100000") ||
        !lsamp__field_valid(log, "desc.rotation", d->rotation, -1000.0f, 1000.0f, "-1000..1000") ||
        !lsamp__field_valid(log, "desc.frames_per_second", d->frames_per_second, 0.0f, 1e6f, "0..1000000") ||
        !lsamp__texels_valid(log, d))
        return 0;
    if ((unsigned)d->filter >= (unsigned)LSAMP_TEXELS_COUNT) {
        if (log) lsamp__log_value(log, "desc.filter", (double)d->filter, "a LSAMP_TEXELS_...");
        return 0;
    }
    switch (d->kind) {
    case LSAMP_LIGHT_DEFAULT:
    case LSAMP_LIGHT_ENVIRONMENT:
        return lsamp__field_valid(log, "desc.cosine_power", d->cosine_power, 0.0f, 0.0f,
                                  "0 for an environment");
    case LSAMP_LIGHT_CALLBACK:
        return d->shape_fn != NULL || lsamp__light_refuse(log, "desc.shape_fn", "is NULL");
    case LSAMP_LIGHT_MESH: return 1;
    case LSAMP_LIGHT_SURFACE: return lsamp__surface_valid(log, d->surface);
    default: break;
    }
    if (!lsamp__field3_valid(log, "desc.position", d->position, -big, big, "-1e18..1e18")) return 0;
    return d->kind <= LSAMP_LIGHT_SPOT ? lsamp__delta_valid(log, d) : lsamp__shape_valid(log, d);
}

static lsamp_result lsamp__emitter_check(const lsamp_light_desc *d, const lsamp__logger *log)
{
    if (!lsamp__fields_valid(d, log)) return LSAMP_ERR_DESC;
    return d->kind == LSAMP_LIGHT_MESH ? lsamp__mesh_light_check(log, d) : LSAMP_OK;
}

static int lsamp__is_environment(const lsamp_light_desc *d)
{
    return d->kind == LSAMP_LIGHT_DEFAULT || d->kind == LSAMP_LIGHT_ENVIRONMENT;
}

#define LSAMP__EMITTER_HEAD ((sizeof(struct lsamp_light) + 15u) & ~(size_t)15u)

LSAMP_DEF size_t lsamp_light_triangles(const lsamp_light *light, float *corners)
{
    uint32_t i;
    if (!light || !light->curve) return 0;
    for (i = 0; corners && i < light->curve->count; i++)
        memcpy(corners + 9u * (size_t)i, light->curve->pieces[i].v, 9 * sizeof *corners);
    return light->curve->count;
}

LSAMP_DEF size_t lsamp_light_bytes(const lsamp_light_desc *desc)
{
    size_t doubles, edges, bytes;
    uint32_t w, h;

    if (!desc || lsamp__emitter_check(desc, NULL) != LSAMP_OK) return 0;
    if (desc->kind == LSAMP_LIGHT_MESH) {
        bytes = lsamp__curve_size(desc);
        return bytes && lsamp__add_size(bytes, LSAMP__EMITTER_HEAD, &bytes) ? bytes : 0;
    }
    if (!desc->texels && !lsamp__is_environment(desc)) return LSAMP__EMITTER_HEAD;
    w = desc->texels ? desc->width : 1u;
    h = desc->texels ? desc->height : 1u;
    edges = lsamp__is_environment(desc) ? h + 1u : 0u;
    doubles = lsamp__cdf2_doubles(w, h);
    /* First come texels, one row of weights and the guides, then the sums. Sides are 65536 at most, so that
       14 h + 4 never overflows. */
    if (!doubles || !lsamp__mul_size(w, (size_t)h * 14u + 4u, &bytes) ||
        !lsamp__add_size(bytes, LSAMP__EMITTER_HEAD + 2u * h, &bytes) ||
        !lsamp__add_size(doubles, edges, &doubles) || !lsamp__mul_size(doubles, sizeof(double), &doubles) ||
        !lsamp__add_size(bytes, doubles, &bytes))
        return 0;
    return bytes;
}

/* Returns cos(pi y / h) to the last digits of a double, by sines up to pi / 4, so that rows at the poles keep
   their digits (T12). */
static double lsamp__row_edge(uint32_t y, uint32_t h)
{
    uint32_t m = y < h - y ? y : h - y;
    double x = 1.5707963267948966 * m / h, z = x * x, s;
    s = 1.0 - z / 110.0 * (1.0 - z / 156.0 * (1.0 - z / 210.0));
    s = x * (1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0 * s))));
    s = 1.0 - 2.0 * s * s;
    return m == y ? s : -s;
}

/* Writes the texels at desc.time, which are blended from the two frames nearest in time; bad channels become
   0. Returns the number of bad texels. */
static uint64_t lsamp__emitter_frame(const lsamp_light_desc *d, float *texels)
{
    uint32_t frames = d->frame_count ? d->frame_count : 1u, f0, f1;
    size_t count = (size_t)d->width * d->height, i;
    double t = (double)d->time * (d->frames_per_second > 0.0f ? (double)d->frames_per_second : 30.0);
    float blend;
    uint64_t bad = 0;

    if (d->loop) t -= floor(t / frames) * frames;
    t = t > 0.0 ? t : 0.0;
    if (!d->loop && t > frames - 1.0) t = frames - 1.0;
    f0 = t < frames ? (uint32_t)t : 0u;
    f1 = (f0 + 1u) % frames;
    blend = t < frames ? (float)(t - f0) : 0.0f;
    for (i = 0; i < count; i++) {
        int c, broken = 0;
        for (c = 0; c < 3; c++) {
            float a = d->texels[(f0 * count + i) * 3u + (size_t)c];
            float b = blend > 0.0f ? d->texels[(f1 * count + i) * 3u + (size_t)c] : 0.0f;
            if (!lsamp__finite(a) || a < 0.0f) broken = 1, a = 0.0f;
            if (!lsamp__finite(b) || b < 0.0f) broken = 1, b = 0.0f;
            texels[i * 3u + (size_t)c] = a * (1.0f - blend) + b * blend;
        }
        bad += (uint64_t)broken;
    }
    return bad;
}

/* Makes the cdf over the texels, in proportion to the light that they send out in all three channels together
   (T18). */
static void lsamp__emitter_cdf(lsamp_light *l, double *memory, float *row, uint16_t *guide)
{
    uint32_t w = l->desc.width, h = l->desc.height, x, y;
    double *rows = memory, *sums = memory + h + 1u, total = 0.0;
    float top = l->radiance.x > l->radiance.y ? l->radiance.x : l->radiance.y, norm;
    lsamp__v3 tint = lsamp__v3_make(1.0f, 1.0f, 1.0f);

    top = top > l->radiance.z ? top : l->radiance.z;
    if (top > 0.0f) tint = lsamp__v3_make(l->radiance.x / top, l->radiance.y / top, l->radiance.z / top);
    tint = lsamp__v3_scale(tint, 1.0f / 3.0f);
    for (y = 0; y < h; y++) {
        lsamp__cdf line;
        double *at = sums + (size_t)y * (w + 1u);
        for (x = 0; x < w; x++) row[x] = lsamp__v3_dot(lsamp__texel_mean(l, x, y), tint);
        (void)lsamp__cdf_build(&line, at, row, w, l->edges ? l->edges[y] - l->edges[y + 1u] : 1.0);
        lsamp__guide_build(at, guide + h + (size_t)y * w, w);
        rows[y] = total;
        total += lsamp__cdf_total(&line);
    }
    rows[h] = total;
    lsamp__guide_build(rows, guide, h);
    l->guide = guide;
    norm = (float)(total > 0.0 ? (l->edges ? w / (6.283185307179586 * total) : (double)w * h / total) : 0.0);
    l->tint = lsamp__v3_scale(tint, norm);
    l->cdf.rows = rows;
    l->cdf.sums = sums;
    l->cdf.width = w;
    l->cdf.height = h;
}

/* Replaces the default kind by what it is, and that of a surface by the kind by whose code it is drawn. */
static void lsamp__emitter_kind(lsamp_light *l)
{
    lsamp_light_desc *d = &l->desc;
    if (d->kind == LSAMP_LIGHT_DEFAULT) d->kind = LSAMP_LIGHT_ENVIRONMENT;
    if (d->kind != LSAMP_LIGHT_SURFACE) d->surface = NULL;
    l->round = d->kind == LSAMP_LIGHT_ENVIRONMENT || d->kind == LSAMP_LIGHT_SPHERE ||
               (d->surface && d->surface->round);
    if (d->surface) d->kind = LSAMP_LIGHT_CALLBACK;
}

static void lsamp__emitter_geometry(lsamp_light *l)
{
    const lsamp_light_desc *d = &l->desc;
    lsamp__v3 u = lsamp__v3_load(d->u), v = lsamp__v3_load(d->v), n;
    float area2;

    l->origin = lsamp__v3_load(d->position);
    l->radiance = lsamp__v3_load(d->radiance);
    l->n = lsamp__v3_normalize(lsamp__v3_load(d->direction));
    l->cos_cone = d->kind == LSAMP_LIGHT_SPOT ? lsamp__cos(d->cone_half_angle) : 0.0f;
    l->turn = d->rotation / (2.0f * LSAMP__PI);
    l->area = 1.0f;
    memcpy(l->location, d->position, sizeof d->position);
    l->location[3] = 1.0f;
    if (d->kind == LSAMP_LIGHT_LINE) {
        l->n = lsamp__v3_normalize(u);
        l->lx = lsamp__v3_length(u);
    } else if (d->kind == LSAMP_LIGHT_DISC) {
        lsamp__v3_basis(l->n, &l->ex, &l->ey);
        l->area = LSAMP__PI * d->radius * d->radius;
    } else if (d->kind == LSAMP_LIGHT_SPHERE) {
        l->area = 4.0f * LSAMP__PI * d->radius * d->radius;
    } else if (d->kind == LSAMP_LIGHT_RECTANGLE) {
        n = lsamp__v3_cross(u, v);
        l->area = lsamp__v3_length(n);
        l->n = lsamp__v3_normalize(n);
        l->lx = lsamp__v3_length(u);
        l->ly = lsamp__v3_length(v);
        area2 = 1.0f / l->area;
        l->ex = lsamp__v3_scale(lsamp__v3_cross(v, l->n), area2);
        l->ey = lsamp__v3_scale(lsamp__v3_cross(l->n, u), area2);
        l->orthogonal = fabsf(lsamp__v3_dot(u, v)) <= 1e-5f * l->area;
    }
}

/* Returns what lsamp_light_init returns, and logs why, for a desc for which lsamp_light_bytes returned 0. */
static lsamp_result lsamp__light_error(const lsamp_light_desc *d, const lsamp__logger *log)
{
    const lsamp_result result = lsamp__emitter_check(d, log);
    if (result != LSAMP_OK) return result;
    lsamp__log_text(log, "desc", "needs more memory than a size_t counts");
    return LSAMP_ERR_LIMIT;
}

static lsamp_result lsamp__refuse(const lsamp__logger *log, lsamp_result result, const char *field,
                                  const char *text)
{
    lsamp__log_text(log, field, text);
    return result;
}

LSAMP_DEF lsamp_result lsamp_light_init(const lsamp_light_desc *desc, void *memory, size_t memory_bytes,
                                         lsamp_light **out, uint64_t *bad_texels)
{
    size_t bytes = lsamp_light_bytes(desc);
    lsamp_light *l = (lsamp_light *)memory;
    uint64_t bad = 0;
    lsamp__logger log;

    if (!desc) return LSAMP_ERR_ARGUMENT;
    log = lsamp__logger_of(&desc->system, "lsamp_light_init");
    if (!memory) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "memory", "is NULL");
    if (!out) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "out", "is NULL");
    if (!bytes) return lsamp__light_error(desc, &log);
    if ((uintptr_t)memory & 7u)
        return lsamp__refuse(&log, LSAMP_ERR_MEMORY, "memory", "is not aligned to 8 bytes");
    if (memory_bytes < bytes) {
        lsamp__log_bound(&log, "memory_bytes", memory_bytes, "at least", bytes, "lsamp_light_bytes(desc)");
        return LSAMP_ERR_MEMORY;
    }
    memset(l, 0, sizeof *l);
    l->desc = *desc;
    l->desc.texels = NULL;
    if (!desc->texels) l->desc.filter = LSAMP_TEXELS_NEAREST;   /* there is nothing to be linear between */
    lsamp__emitter_kind(l);
    lsamp__emitter_geometry(l);
    if (desc->kind == LSAMP_LIGHT_MESH) {
        lsamp__curve *curve;
        lsamp_result result = lsamp__curve_build(desc, (char *)memory + LSAMP__EMITTER_HEAD, &curve);
        if (result != LSAMP_OK) return lsamp__refuse(&log, result, "desc.mesh", "has no area");
        l->curve = curve;
        l->desc.kind = LSAMP_LIGHT_CALLBACK;
    }
    if (desc->texels || lsamp__is_environment(desc)) {
        static const float white[3] = { 1.0f, 1.0f, 1.0f };
        double *sums = (double *)(void *)((char *)memory + LSAMP__EMITTER_HEAD);
        float *texels, *row;
        uint32_t y;

        if (!desc->texels) {
            l->desc.width = l->desc.height = 1;
            l->desc.texels = white;
        } else {
            l->desc.texels = desc->texels;
        }
        if (lsamp__is_environment(desc)) {
            for (y = 0; y <= l->desc.height; y++) sums[y] = lsamp__row_edge(y, l->desc.height);
            l->edges = sums;
            sums += l->desc.height + 1u;
        }
        texels = (float *)(void *)(sums + lsamp__cdf2_doubles(l->desc.width, l->desc.height));
        bad = lsamp__emitter_frame(&l->desc, texels);
        l->desc.texels = texels;
        row = texels + (size_t)l->desc.width * l->desc.height * 3u;
        lsamp__emitter_cdf(l, sums, row, (uint16_t *)(void *)(row + l->desc.width));
    }
    if (bad_texels) *bad_texels = bad;
    *out = l;
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_light_domain(const lsamp_light *light, lsamp_domain *out)
{
    static const lsamp_domain_kind kinds[10] = { LSAMP_DOMAIN_LATLONG,   LSAMP_DOMAIN_LATLONG,
                                                 LSAMP_DOMAIN_LATLONG,   LSAMP_DOMAIN_LIST,
                                                 LSAMP_DOMAIN_LIST,      LSAMP_DOMAIN_LINE,
                                                 LSAMP_DOMAIN_RECTANGLE, LSAMP_DOMAIN_DISC,
                                                 LSAMP_DOMAIN_SPHERE,    LSAMP_DOMAIN_TABLE };
    const lsamp_light_desc *d;
    lsamp__logger log;

    if (!light) return LSAMP_ERR_ARGUMENT;
    d = &light->desc;
    log = lsamp__logger_of(&d->system, "lsamp_light_domain");
    if (!out) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "out", "is NULL");
    if (d->kind == LSAMP_LIGHT_CALLBACK && !light->curve)
        return lsamp__refuse(&log, LSAMP_ERR_MISMATCH, "light",
                             "is a callback or a surface, which has no domain of its own");
    memset(out, 0, sizeof *out);
    out->kind = kinds[d->kind];
    if (light->curve) {
        out->side[0] = light->curve->places;
        out->side[1] = out->side[2] = 1;
        out->locations = light->curve->locations;
        out->location_count = light->curve->places;
        return LSAMP_OK;
    }
    memcpy(out->origin, d->position, sizeof out->origin);
    memcpy(out->u, d->u, sizeof out->u);
    memcpy(out->v, d->v, sizeof out->v);
    if (d->kind == LSAMP_LIGHT_DISC) {
        lsamp__v3_store(out->u, lsamp__v3_scale(light->ex, d->radius));
        lsamp__v3_store(out->v, lsamp__v3_scale(light->ey, d->radius));
    } else if (d->kind == LSAMP_LIGHT_SPHERE) {
        lsamp__v3_store(out->u, lsamp__v3_make(d->radius, 0.0f, 0.0f));
    } else if (out->kind == LSAMP_DOMAIN_LIST) {
        out->locations = light->location;
        out->location_count = 1;
    }
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_surface_locations(const lsamp_surface *surface, uint32_t width, uint32_t height,
                                               float lift, float *locations)
{
    uint32_t i, j;

    if (!surface || !locations || !width || !height) return LSAMP_ERR_ARGUMENT;
    if (!lsamp__surface_valid(NULL, surface) || !lsamp__finite(lift)) return LSAMP_ERR_INPUT;
    for (j = 0; j < height; j++)
        for (i = 0; i < width; i++, locations += 4) {
            const float x = ((float)i + 0.5f) / (float)width, y = ((float)j + 0.5f) / (float)height;
            float q[3], n[3], area;
            lsamp__surface_point(surface, x, y, q, n, &area);
            lsamp__v3_store(locations, lsamp__v3_madd(lsamp__v3_load(q),
                                                      lsamp__v3_normalize(lsamp__v3_load(n)), lift));
            locations[3] = 1.0f;
        }
    return LSAMP_OK;
}

LSAMP_DEF int lsamp_light_sample(const lsamp_light *light, const float p[3], const float u[3],
                                 lsamp_emission *out)
{
    lsamp__aim aim;
    lsamp_emission e;

    if (!light || !p || !u || !out || !lsamp__v3_finite(lsamp__v3_load(p)) || !lsamp__in3(u, 0.0f, 1.0f))
        return 0;
    if (!lsamp__aim_at(&aim, light, lsamp__v3_load(p)) || !lsamp__emitter_draw(&aim, u, &e)) return 0;
    *out = e;
    return 1;
}

LSAMP_DEF int lsamp_light_hit(const lsamp_light *light, const float p[3], const float direction[3],
                              lsamp_emission *out)
{
    lsamp__aim aim;
    lsamp_emission e;

    if (!light || !p || !direction || !out || !lsamp__v3_finite(lsamp__v3_load(p)) ||
        !lsamp__is_unit(direction))
        return 0;
    if (!lsamp__aim_at(&aim, light, lsamp__v3_load(p)) ||
        !lsamp__aim_hit(&aim, lsamp__v3_normalize(lsamp__v3_load(direction)), &e))
        return 0;
    *out = e;
    return 1;
}

/* ==== src/lightsampling/patterns.h ==== */

/* ---- patterns: the random numbers of samples ---- */

LSAMP_DEF size_t lsamp_patterns_bytes(uint32_t length)
{
    if (length == 0 || length > 65536u) return 0;
    return (size_t)LSAMP_PATTERN_COUNT * length * 2u * sizeof(float);
}

/* The points are Hammersley points, of which one axis is jittered inside the columns and the other is
   Owen-scrambled. They are computed in integers of 24 bits, so that no rounding takes a point across the edge
   of its column. */
LSAMP_DEF lsamp_result lsamp_patterns_build(uint32_t length, uint32_t seed, float *patterns, size_t bytes)
{
    size_t need = lsamp_patterns_bytes(length);
    uint32_t j, k;

    if (!patterns || !need) return LSAMP_ERR_ARGUMENT;
    if (bytes < need) return LSAMP_ERR_MEMORY;
    for (j = 0; j < LSAMP_PATTERN_COUNT; j++) {
        uint32_t scramble = lsamp__hash_combine(seed, j);
        for (k = 0; k < length; k++, patterns += 2) {
            uint32_t low = (uint32_t)((((uint64_t)k << 24) + length - 1u) / length);
            uint32_t high = (uint32_t)((((uint64_t)(k + 1u) << 24) + length - 1u) / length);
            uint32_t at = low + (uint32_t)(lsamp__random(seed, ~j, k) * (float)(high - low));
            patterns[0] = (float)(at < high ? at : high - 1u) * (1.0f / 16777216.0f);
            patterns[1] = lsamp__to_unit(lsamp__owen(lsamp__reverse_bits(k), scramble));
        }
    }
    return LSAMP_OK;
}

/* Writes the random numbers of sample k of a pixel, the third one for callbacks only. 159 is odd and close to
   256 / golden ratio, so that the patterns of successive frames are far apart, and all 256 get their turn;
   then they come again with a toroidal shift. */
static void lsamp__random_numbers(const lsamp_sample_desc *d, uint32_t pixel, uint32_t k, int third, float *u)
{
    uint32_t key = lsamp__hash_combine(d->seed, pixel), index = d->frame * d->sample_count + k;

    if (d->patterns) {
        const float *at = d->patterns + ((size_t)((key + d->frame * 159u) & 255u) * d->sample_count + k) * 2u;
        u[0] = at[0];
        u[1] = at[1];
        if (d->frame > 255u) {
            u[0] += lsamp__random(key, d->frame >> 8, 0u);
            u[1] += lsamp__random(key, d->frame >> 8, 1u);
            u[0] = lsamp__clamp_unit(u[0] - floorf(u[0]));
            u[1] = lsamp__clamp_unit(u[1] - floorf(u[1]));
        }
    } else {
        lsamp__sobol2(index, key, &u[0], &u[1]);
    }
    u[2] = third ? lsamp__random(key, 0x9e3779b9u, index) : 0.0f;
}

/* ==== src/lightsampling/estimator.h ==== */

/* ---- estimator: samples and their weights ---- */

typedef struct lsamp__estimator { /* one point and one light */
    const lsamp_sample_desc *desc;
    lsamp__surface surface;
    lsamp__aim     aim;
    int            reachable;    /* light can reach the point, and the point is a receiver */
    int            split;        /* as in the paper, the two parts of the BRDF are integrated apart */
    float          light_share;  /* the share of samples that the light draws; the BRDF draws the others */
} lsamp__estimator;

/* Decides how many samples the light draws and how many the BRDF: the BRDF draws few if the light is smaller
   than the lobe, and the light draws few if the lobe is smaller. With q = (solid angle) (peak density), a
   share of q^3 / (8 + q^3) for the BRDF gave 0.29 of the noise that shares of one half gave (geometric mean
   over 54 pairs of light and material, 64 samples), and 0.68 of it under shadows; q / (1 + q) gave 0.52 and
   0.76. The shares are whole samples, so that stratified numbers are split without a remainder. */
static void lsamp__estimator_init(lsamp__estimator *e, const lsamp_sample_desc *desc,
                                  const lsamp_light *light)
{
    int unseen = lsamp__is_delta(light) || light->desc.kind == LSAMP_LIGHT_CALLBACK;
    int distant = light->desc.kind == LSAMP_LIGHT_ENVIRONMENT;
    float q;

    e->desc = desc;
    e->split = distant && desc->sampling == LSAMP_SAMPLING_PAPER;
    e->light_share = 1.0f;
    if (unseen || desc->sampling == LSAMP_SAMPLING_LIGHT || !e->reachable) return;
    if (desc->sampling == LSAMP_SAMPLING_BRDF) e->light_share = 0.0f;
    else if (desc->sampling == LSAMP_SAMPLING_PAPER)
        e->light_share = distant ? e->surface.diffuse_share : 1.0f;
    else if (distant) e->light_share = 0.5f;
    else {
        q = e->aim.solid * e->surface.peak;
        e->light_share = 8.0f / (8.0f + q * q * q);
        e->light_share =
            floorf(e->light_share * (float)desc->sample_count + 0.5f) / (float)desc->sample_count;
    }
}

/* Draws one sample and returns its weight times S. The first number decides by roulette between light and
   BRDF, and is then stretched again for the drawing. The densities of both techniques are summed in
   proportion, which is the one-sample form of the balance heuristic. */
static lsamp__v3 lsamp__estimate(const lsamp__estimator *e, const float *numbers, lsamp_emission *found)
{
    const lsamp__v3 zero = lsamp__v3_make(0.0f, 0.0f, 0.0f);
    const lsamp__surface *s = &e->surface;
    float u[3], c = e->light_share, pdf;
    int by_light = numbers[0] < c, hit;
    lsamp__v3 wi, f;
    lsamp__response r;

    u[0] = lsamp__clamp_unit(by_light ? numbers[0] / c : (numbers[0] - c) / (1.0f - c));
    u[1] = numbers[1];
    u[2] = numbers[2];
    if (by_light) {
        hit = lsamp__emitter_draw(&e->aim, u, found);
    } else {
        wi = lsamp__brdf_draw(s, e->split ? 0.0f : s->diffuse_share, u[0], u[1]);
        hit = wi.z > 0.0f && lsamp__aim_hit(&e->aim, lsamp__from_axes(s->t, s->b, s->n, wi), found);
    }
    if (!hit) {
        memset(found, 0, sizeof *found);
        return zero;
    }
    wi = lsamp__to_axes(s, lsamp__v3_load(found->direction));
    r = lsamp__brdf_response(s, wi);
    if (e->split) {
        f = by_light ? r.diffuse : r.specular;
        pdf = by_light ? c * found->pdf : (1.0f - c) * r.specular_pdf;
    } else {
        f = lsamp__v3_add(r.diffuse, r.specular);
        pdf = c * found->pdf + (1.0f - c) * lsamp__brdf_pdf(s, &r);
    }
    if (!(wi.z > 0.0f) || !(pdf > 0.0f)) return zero;
    f = lsamp__v3_scale(lsamp__v3_mul(f, lsamp__v3_load(found->radiance)), wi.z / pdf);
    return lsamp__v3_finite(f) ? f : zero;
}

#define LSAMP__SAMPLE_BLOCK 32u

/* Prefetches the rows, sums and texels that the light's samples of a block will read, one dependency at a
   time, since large maps do not fit into the cache. */
static void lsamp__environment_warm(const lsamp__estimator *e, float (*u)[3], uint32_t count)
{
    const lsamp_light *l = e->aim.light;
    uint32_t k, w = l->desc.width, h = l->desc.height;
    size_t at[LSAMP__SAMPLE_BLOCK];
    float unused;

    if (l->desc.kind != LSAMP_LIGHT_ENVIRONMENT || !(lsamp__cdf2_total(&l->cdf) > 0.0)) return;
    for (k = 0; k < count; k++) {
        uint32_t y = lsamp__invert_sums(l->cdf.rows, l->guide, h, u[k][1], &unused);
        at[k] = (size_t)y * w;
        if (!(u[k][0] < e->light_share)) continue;
        LSAMP__PREFETCH(l->guide + h + at[k] + lsamp__cell_of(u[k][0] / e->light_share, w));
    }
    for (k = 0; k < count; k++) {
        uint32_t x;
        if (!(u[k][0] < e->light_share)) continue;
        x = l->guide[h + at[k] + lsamp__cell_of(u[k][0] / e->light_share, w)];
        LSAMP__PREFETCH(l->cdf.sums + at[k] + at[k] / w + x);
        LSAMP__PREFETCH(l->desc.texels + (at[k] + x) * 3u);
    }
}

static const float *lsamp__vector_at(const float *base, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)base + (stride ? stride : 12u) * i);
}

static const lsamp_material *lsamp__material_at(const lsamp_points *p, size_t i)
{
    return (const lsamp_material *)(const void *)((const char *)p->materials + p->material_stride * i);
}

/* Says whether a vector is 0 0 0 or not finite, by which a point is no receiver. */
static int lsamp__is_none(const float *p)
{
    return (p[0] == 0.0f && p[1] == 0.0f && p[2] == 0.0f) || !lsamp__v3_finite(lsamp__v3_load(p));
}

/* Says whether point i is lit at all: its position and vectors are there and finite. */
static int lsamp__is_receiver(const lsamp_points *p, size_t i)
{
    return lsamp__v3_finite(lsamp__v3_load(lsamp__vector_at(p->positions, p->position_stride, i))) &&
           !lsamp__is_none(lsamp__vector_at(p->normals, p->normal_stride, i)) &&
           !(p->to_eye && lsamp__is_none(lsamp__vector_at(p->to_eye, p->to_eye_stride, i))) &&
           !(p->tangents && lsamp__is_none(lsamp__vector_at(p->tangents, p->tangent_stride, i)));
}

/* Returns LSAMP_ERR_INPUT, and logs so, if vector i of an array is not unit. */
static lsamp_result lsamp__unit_check(const char *array, const float *vectors, size_t stride, size_t i,
                                      const lsamp__logger *log)
{
    const float *p = lsamp__vector_at(vectors, stride, i);
    if (lsamp__is_unit(p)) return LSAMP_OK;
    lsamp__log_element(log, array, i, "has the length", (double)lsamp__v3_length(lsamp__v3_load(p)),
                       "1 (0.97..1.03), or 0");
    return LSAMP_ERR_INPUT;
}

static lsamp_result lsamp__stride_check(const char *field, size_t stride, const lsamp__logger *log)
{
    if (lsamp__stride_valid(stride, 12)) return LSAMP_OK;
    lsamp__log_value(log, field, (double)stride, "0 or a multiple of 4 from 12 on");
    return LSAMP_ERR_ARGUMENT;
}

/* Checks the arrays of points, but not what is in them. */
static lsamp_result lsamp__arrays_check(const lsamp_points *p, const lsamp__logger *log)
{
    lsamp_result result = LSAMP_OK;

    if (!p->positions) return lsamp__refuse(log, LSAMP_ERR_ARGUMENT, "points.positions", "is NULL");
    if (!p->normals) return lsamp__refuse(log, LSAMP_ERR_ARGUMENT, "points.normals", "is NULL");
    if (!p->materials) return lsamp__refuse(log, LSAMP_ERR_ARGUMENT, "points.materials", "is NULL");
    if (result == LSAMP_OK) result = lsamp__stride_check("points.position_stride", p->position_stride, log);
    if (result == LSAMP_OK) result = lsamp__stride_check("points.normal_stride", p->normal_stride, log);
    if (result == LSAMP_OK) result = lsamp__stride_check("points.to_eye_stride", p->to_eye_stride, log);
    if (result == LSAMP_OK) result = lsamp__stride_check("points.tangent_stride", p->tangent_stride, log);
    if (result == LSAMP_OK && (p->material_stride % sizeof(void *) ||
                               (p->material_stride && p->material_stride < sizeof(lsamp_material)))) {
        lsamp__log_value(log, "points.material_stride", (double)p->material_stride,
                         "0, or sizeof(lsamp_material) or above, a multiple of sizeof(void *)");
        result = LSAMP_ERR_ARGUMENT;
    }
    return result;
}

static lsamp_result lsamp__points_check(const lsamp_points *p, const lsamp__logger *log)
{
    lsamp_result result = LSAMP_OK;
    lsamp__fault fault;
    size_t i;

    if (p->count == 0) return LSAMP_OK;
    result = lsamp__arrays_check(p, log);
    for (i = 0; i < p->count && result == LSAMP_OK; i++) {
        if ((i == 0 || p->material_stride) && !lsamp__material_valid(lsamp__material_at(p, i), &fault)) {
            lsamp__log_element(log, "points.materials", i, fault.field, (double)fault.value, fault.wanted);
            return LSAMP_ERR_INPUT;
        }
        if (!lsamp__is_receiver(p, i)) continue;
        result = lsamp__unit_check("points.normals", p->normals, p->normal_stride, i, log);
        if (result == LSAMP_OK && p->to_eye)
            result = lsamp__unit_check("points.to_eye", p->to_eye, p->to_eye_stride, i, log);
        if (result == LSAMP_OK && p->tangents)
            result = lsamp__unit_check("points.tangents", p->tangents, p->tangent_stride, i, log);
    }
    return result;
}

/* Draws all samples of one point, the first of which has the number at. Returns how many have a weight. */
static size_t lsamp__sample_point(const lsamp__estimator *e, uint32_t pixel, const lsamp_samples *out,
                                  size_t at)
{
    uint32_t count = e->desc->sample_count, k, b, block;
    int third = e->aim.light->desc.kind == LSAMP_LIGHT_CALLBACK;
    float u[LSAMP__SAMPLE_BLOCK][3], scale = 1.0f / (float)count;
    size_t useful = 0;

    for (k = 0; k < count; k += block) {
        block = count - k < LSAMP__SAMPLE_BLOCK ? count - k : LSAMP__SAMPLE_BLOCK;
        if (e->reachable) {
            for (b = 0; b < block; b++) lsamp__random_numbers(e->desc, pixel, k + b, third, u[b]);
            lsamp__environment_warm(e, u, block);
        }
        for (b = 0; b < block; b++, at++) {
            lsamp__v3 weight = lsamp__v3_make(0.0f, 0.0f, 0.0f);
            lsamp_emission found;

            memset(&found, 0, sizeof found);
            if (e->reachable) weight = lsamp__v3_scale(lsamp__estimate(e, u[b], &found), scale);
            if (!(found.pdf > 0.0f)) {
                lsamp__v3_store(found.direction, e->surface.n);
                found.distance = LSAMP_INFINITY;
            }
            useful += weight.x + weight.y + weight.z > 0.0f;
            memcpy(out->directions + at * 3u, found.direction, sizeof found.direction);
            out->distances[at] = found.distance;
            if (out->coords) memcpy(out->coords + at * 3u, found.coords, sizeof found.coords);
            lsamp__v3_store(out->weights + at * 3u, weight);
        }
    }
    return useful;
}

LSAMP_DEF lsamp_result lsamp_sample(const lsamp_sample_desc *desc, const lsamp_light *light,
                                    const lsamp_points *points, const lsamp_samples *out, size_t *useful)
{
    lsamp_result result;
    lsamp__logger log;
    size_t i, n = 0, total;

    if (!desc) return LSAMP_ERR_ARGUMENT;
    log = lsamp__logger_of(&desc->system, "lsamp_sample");
    if (!light) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "light", "is NULL");
    if (!points) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "points", "is NULL");
    if (!out) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "out", "is NULL");
    if (!out->directions) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "out.directions", "is NULL");
    if (!out->distances) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "out.distances", "is NULL");
    if (!out->weights) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "out.weights", "is NULL");
    if (desc->sample_count == 0 || desc->sample_count > 65536u) {
        lsamp__log_value(&log, "desc.sample_count", (double)desc->sample_count, "1..65536");
        return LSAMP_ERR_DESC;
    }
    if ((unsigned)desc->sampling >= (unsigned)LSAMP_SAMPLING_COUNT) {
        lsamp__log_value(&log, "desc.sampling", (double)desc->sampling, "a LSAMP_SAMPLING_...");
        return LSAMP_ERR_DESC;
    }
    if (!lsamp__mul_size(points->count, (size_t)desc->sample_count * 12u, &total)) {
        lsamp__log_value(&log, "points.count", (double)points->count, "less: out does not fit a size_t");
        return LSAMP_ERR_LIMIT;
    }
    result = lsamp__points_check(points, &log);
    if (result != LSAMP_OK) return result;
    for (i = 0; i < points->count; i++) {
        lsamp__estimator e;
        const float *normal = lsamp__vector_at(points->normals, points->normal_stride, i);
        const float *view =
            points->to_eye ? lsamp__vector_at(points->to_eye, points->to_eye_stride, i) : normal;
        const float *tangent =
            points->tangents ? lsamp__vector_at(points->tangents, points->tangent_stride, i) : NULL;
        const float *p = lsamp__vector_at(points->positions, points->position_stride, i);

        if (!lsamp__is_receiver(points, i)) {
            memset(&e, 0, sizeof e);
            e.aim.light = light;
        } else {
            lsamp__surface_init(&e.surface, lsamp__material_at(points, i), lsamp__v3_load(normal), tangent,
                                lsamp__v3_load(view));
            e.reachable = lsamp__aim_at(&e.aim, light, lsamp__v3_load(p)) && !e.surface.black;
        }
        lsamp__estimator_init(&e, desc, light);
        n +=
            lsamp__sample_point(&e, points->pixels ? points->pixels[i] : (uint32_t)i, out,
                                i * desc->sample_count);
    }
    if (useful) *useful = n;
    return LSAMP_OK;
}

/* ---- accumulate: sums over samples and frames ---- */

LSAMP_DEF lsamp_result lsamp_accumulate(size_t count, uint32_t sample_count, const float *weights,
                                        const float *visible, float *radiance, size_t radiance_stride)
{
    size_t i, c, at = 0;
    uint32_t k;

    if (sample_count == 0 || (count && (!weights || !radiance)) || !lsamp__stride_valid(radiance_stride, 12))
        return LSAMP_ERR_ARGUMENT;
    for (i = 0; i < count; i++) {
        float *out = (float *)(void *)((char *)radiance + (radiance_stride ? radiance_stride : 12u) * i);
        double sum[3] = { 0.0, 0.0, 0.0 };

        for (k = 0; k < sample_count; k++, at++) {
            const float *w = weights + at * 3u;
            double v;
            if (w[0] == 0.0f && w[1] == 0.0f && w[2] == 0.0f) continue;
            v = visible ? (double)visible[at] : 1.0;
            if (!(v > 0.0)) continue;       /* also of COHSM_REFUSED */
            for (c = 0; c < 3; c++) sum[c] += v * (double)w[c];
        }
        for (c = 0; c < 3; c++) out[c] += (float)sum[c];
    }
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_progressive_reset(lsamp_progressive *p)
{
    size_t i;
    if (!p || (p->count && !p->sums)) return LSAMP_ERR_ARGUMENT;
    for (i = 0; i < p->count; i++) p->sums[i] = 0.0;
    p->frame_count = 0;
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_progressive_add(lsamp_progressive *p, const float *frame)
{
    size_t i;
    if (!p || (p->count && (!p->sums || !frame))) return LSAMP_ERR_ARGUMENT;
    if (p->frame_count == UINT32_MAX) return LSAMP_ERR_LIMIT;
    for (i = 0; i < p->count; i++) p->sums[i] += (double)frame[i];
    p->frame_count++;
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_progressive_mean(const lsamp_progressive *p, float *mean)
{
    size_t i;
    if (!p || (p->count && (!p->sums || !mean))) return LSAMP_ERR_ARGUMENT;
    if (p->frame_count == 0) return LSAMP_ERR_ORDER;
    for (i = 0; i < p->count; i++) mean[i] = (float)(p->sums[i] / (double)p->frame_count);
    return LSAMP_OK;
}

/* ==== src/shared/fp_end.h ==== */

/* unit fp_end: the user's options again. clang and MSVC keep contraction off to the end of the file. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__)
#pragma GCC pop_options
#endif

/* ==== src/lightsampling/end.h ==== */

#endif /* LIGHTSAMPLING_IMPLEMENTATION */

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
