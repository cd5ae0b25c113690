/* envlights.h - v1.0.0 - a sky as k directional lights, for any renderer - MIT-0 OR Unlicense

   What it does

   Turns a radiance map of the surroundings into k directional lights, by importance, so that the lights have
   the energy of the map; follows a map that changes from frame to frame; moves lights inside their strata;
   computes what the lights leave out; and writes the lights as glTF. The lights are those of Knuth and
   Fuhrmann, "Self-Shadowing of Dynamic Scenes with Environment Maps using the GPU", WSCG 2005, whose shadows
   are in envshadow.h. There are four methods: Agarwal, Ramamoorthi, Belongie and Jensen, "Structured
   importance sampling of environment maps", SIGGRAPH 2003, which that paper takes; Debevec, "A median cut
   algorithm for light probe sampling", 2005; Viriyothai and Debevec, "Variance minimization light probe
   sampling", 2009; and inversion of the distribution.

   What it does not do

   - Lights are infinitely far away: no light comes from a place inside the scene, and every point of the
     scene sees the same map.
   - It computes no shadows: envshadow.h renders a shadow map for each light; csm.h and any ray tracer can
     take the lights too.
   - It renders no pictures, opens no files and starts no threads.

   Quick start

   Write the define in exactly one source file; include the header alone everywhere else.

       #define ENVLIGHTS_IMPLEMENTATION
       #include "envlights.h"
       #include <stdio.h>

       int main(void)
       {
           static float sky[3 * 64 * 32];
           envlt_map map = { ENVLT_PROJECTION_LATLONG, 64, 32, sky, 0 };
           envlt_lights *lights;
           const envlt_light *list;
           uint32_t count;
           float ground = 0;

           for (int i = 0; i < 3 * 64 * 16; i++) sky[i] = 1;    // bright above, black below
           if (envlt_create(NULL, &map, &lights, NULL) != ENVLT_OK) return 1;
           list = envlt_get_lights(lights, &count);
           for (uint32_t i = 0; i < count; i++) ground += list[i].direction[1] * list[i].irradiance[0];
           printf("%u lights, the ground gets %.2f\n", (unsigned)count, (double)ground);      // pi
           envlt_free(lights);
           return !(ground > 3.1f && ground < 3.2f);
       }

   Conventions

   Coordinates are right-handed and +Y is up (turn the lights by envlt_rotate for a scene whose up is Z);
   matrices are column-major float[16]; directions have unit length and point to the light; angles are in
   radians, radiance in W/(sr m^2), irradiance in W/m^2. A vector that is called unit may have a length from
   0.97 to 1.03 and is used as it is; any other length is an error. Directions that this header makes are unit
   within 1e-6.

     map        the environment: radiance of all directions, latitude-longitude or six cube faces, one float
                RGB a texel
     light      a directional light that stands for a stratum
     stratum    a region of the map that one light stands for: the light's irradiance is the sum of
                radiance x solid angle over the stratum, for each channel
     extent     how far the stratum's radiance spreads about the light's direction: an ellipse, given by its
                two half axes

   A latitude-longitude map has +Y in row 0; a direction lies at v = acos(y) / pi from the top and
   u = 0.5 + atan2(z, x) / (2 pi) from the left. A cube map has its faces +X -X +Y -Y +Z -Z one after another,
   each as OpenGL stores it.

   How it works

   The energy of a texel is its luminance x its solid angle, which is computed exactly. STRUCTURED thresholds
   the map into six layers, shares the lights out among the connected bright regions by the importance
   L min(w, 0.01 sr)^(1/4) of a region with energy L and solid angle w, and spreads them within a region by
   farthest-first traversal. MEDIAN_CUT cuts a region across its longer side into two of the same energy.
   VARIANCE cuts a region where the cut lowers the spread of directions most. CDF inverts the cumulative
   distribution at the points (i + 0.5) / n of a grid. Cuts of latitude-longitude maps begin at the column of
   least energy, so that turning the map turns the lights.

   From the paper to the code

     Knuth 2005, 3, Fig. 1, importance     envlt_create                                T17 T18 T19 T20 T22
     Knuth 2005, 3, rotation of the map    envlt_rotate                                T21
     Knuth 2005, 3, jitter in a stratum    envlt_jitter                                T15 irradiance
     Knuth 2005, 6, size of the light      envlt__find_extent; axis_u of envlt_light   -
     Agarwal 2003, structured sampling     envlt__run_structured                       T19 T20 T21
     Debevec 2005, median cut              envlt__run_median                           T19 T20 T21
     Viriyothai 2009, minimum variance     envlt__best_cut                             T19 T20 T21 irradiance
     inversion of the distribution         envlt__run_inversion                        T19 T20 T21
     solid angles                          envlt_texel_solid_angle                     T11 T12 T13
     sums over large maps                  envlt_create                                T16

   The last column names the rows of docs/conformance.md that test a line. A - says that there is none;
   extents are held to a disc's radius by tests/envlights/lights_rows_test.c.

   The knobs, and what each trades:

     light_count   With few lights the shadow edges of single lights can be seen; with many a renderer needs
                   more time and memory.
     method        VARIANCE has the smallest errors by measurement (docs/measured/envlights.md).
     split_sun     A small bright spot becomes a light of its own, with the extent of the spot and not of its
                   surroundings.
     hemisphere    Directions below the horizon are left out, so that no light is spent on them.

   A build takes at most 76 bytes of memory for each texel of the map (79 with split_sun; 45 and 50 by
   MEDIAN_CUT and CDF) and half a kilobyte for each light. It keeps 16 bytes a texel and a quarter of a
   kilobyte a light.

   Configuration

     ENVLIGHTS_IMPLEMENTATION   in one source file: compiles the code
     ENVLT_STATIC               beside it: a private copy for this file, all functions static
     ENVLT_DEF                  everywhere: your own linkage instead

   Memory, errors, threads, determinism

   All memory comes from the allocator in desc.system, called from the thread that called us. Every function
   that can fail returns an envlt_result; if the result is not ENVLT_OK, outputs are untouched, nothing leaks,
   and a call that has a desc or an envlt_lights tells its system.log which field is wrong. There are no
   globals: any number of threads may read the same lights at once; a call that changes them needs them to
   itself. Lights have the same bytes on every compiler and byte order (not with x87 arithmetic, nor clang's
   -ffast-math).

   Cost: docs/measured/envlights.md, build/bench envshadow_lights.   History: CHANGELOG.md.
   Licence: end of this file. */
#ifndef ENVLIGHTS_H
#define ENVLIGHTS_H

#define ENVLT_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "envlights.h needs C99 or C++11"
#endif
#if defined(ENVLT_STATIC) && !defined(ENVLIGHTS_IMPLEMENTATION)
#error "ENVLT_STATIC makes all functions private: ENVLIGHTS_IMPLEMENTATION belongs into the same file"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef ENVLT_DEF
#ifdef ENVLT_STATIC
#define ENVLT_DEF static inline
#else
#define ENVLT_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/envlights/api.h ==== */

/* ---- page one: a sky becomes lights ---- */

#define ENVLT_RESULTS(X)                                                                                     \
    X(ENVLT_OK, "ok")                                                                                        \
    X(ENVLT_ERR_ARGUMENT, "a pointer is NULL, or a count or stride is out of range")                         \
    X(ENVLT_ERR_DESC, "a field of a desc is out of range")                                                   \
    X(ENVLT_ERR_INPUT, "the data cannot be used")                                                            \
    X(ENVLT_ERR_ALLOC, "the allocator returned no memory")                                                   \
    X(ENVLT_ERR_MEMORY, "the caller's memory is too small or misaligned")                                    \
    X(ENVLT_ERR_LIMIT, "a size overflows or passes a limit")                                                 \
    X(ENVLT_ERR_CANCELLED, "cancelled by the progress callback")                                             \
    X(ENVLT_ERR_ORDER, "this call comes too early, too late or twice")                                       \
    X(ENVLT_ERR_FORMAT, "not a file of this kind, or a damaged one")                                         \
    X(ENVLT_ERR_VERSION, "a file of an unknown version")                                                     \
    X(ENVLT_ERR_MISMATCH, "what was given does not belong together")

typedef enum envlt_result {
#define ENVLT__ENUM(name, text) name,
    ENVLT_RESULTS(ENVLT__ENUM)
#undef ENVLT__ENUM
    ENVLT_RESULT_COUNT
} envlt_result;

typedef enum envlt_projection {     /* how the sphere of directions lies on a map */
    ENVLT_PROJECTION_DEFAULT,       /* = ENVLT_PROJECTION_LATLONG */
    ENVLT_PROJECTION_LATLONG,       /* latitude and longitude: row 0 is +Y */
    ENVLT_PROJECTION_CUBE,          /* six faces, +X -X +Y -Y +Z -Z */
    ENVLT_PROJECTION_COUNT
} envlt_projection;

typedef struct envlt_map {          /* the sky */
    envlt_projection projection;
    uint32_t     width, height;     /* of the map, or of one face of a cube, which must be a square; at most
                                       2^27 texels in all */
    const float *rgb;               /* linear radiance of each texel, W/(sr m^2); row 0 first, the faces of a
                                       cube one after another */
    size_t       texel_stride;      /* bytes from one texel to the next, a multiple of 4, >= 12; 0 = 12 */
} envlt_map;

typedef struct envlt_light {        /* a directional light that stands for a stratum, a region of the map */
    float    direction[3];          /* unit, towards the light: the mean of the stratum's directions, weighted
                                       by luminance */
    float    irradiance[3];         /* of a surface that faces the light, W/m^2: the sum of radiance x solid
                                       angle over the stratum */
    float    solid_angle;           /* of the stratum, sr */
    float    axis_u[3], axis_v[3];  /* extent: half axes of the ellipse over which the stratum's radiance
                                       spreads, at right angles to direction and to each other, with
                                       |axis_u| >= |axis_v|. Lengths are tangents of angles, below 1e3 */
    uint32_t id;                    /* stays with a light through envlt_follow and envlt_match */
    uint32_t flags;                 /* ENVLT_LIGHT_SUN or 0 */
} envlt_light;

#define ENVLT_LIGHT_SUN 1u          /* the light is what split_sun took out of the map */

typedef struct envlt_lights envlt_lights;   /* lights and their strata, kept from frame to frame */
typedef struct envlt_desc envlt_desc;       /* how many lights, by which method: below */
typedef struct envlt_stats envlt_stats;     /* what a call counted: below */

ENVLT_DEF envlt_result envlt_create(const envlt_desc *desc, const envlt_map *map, envlt_lights **out,
                                    envlt_stats *stats);
/* Makes lights that together have the energy of the map. The map is not kept.
   desc    NULL = all defaults: 128 lights by minimum variance
   out     receives the lights, on ENVLT_OK only; give them back by envlt_free. A black map gives 0 lights
   stats   may be NULL; receives what the call counted, on ENVLT_OK only
   Errors  ENVLT_ERR_ARGUMENT: map, map->rgb or out is NULL, a side is 0, the faces of a cube are not squares,
           or the stride is out of range.
           ENVLT_ERR_DESC: a field of desc is out of range.
           ENVLT_ERR_INPUT: there is no such projection.
           ENVLT_ERR_LIMIT: the map has more than 2^27 texels.
           ENVLT_ERR_ALLOC: the allocator returned no memory.
   Cost    about 20 ms for 1024 x 512 texels and 300 lights; the time is O(texels log k) */

ENVLT_DEF const envlt_light *envlt_get_lights(const envlt_lights *lights, uint32_t *count);
/* Returns the array of lights, which is valid until the next envlt_follow or envlt_free, and writes how many
   there are. envshadow.h can read the array as it is: envsh_lights with a stride of sizeof(envlt_light).
   lights  NULL gives NULL and a count of 0
   count   may be NULL */

ENVLT_DEF envlt_result envlt_follow(envlt_lights *lights, const envlt_map *map, uint32_t light_count,
                                    envlt_stats *stats);
/* Changes the lights to those of the next frame of a video map, or to another number of lights. Each light
   keeps its stratum, so that a light moves only by what changed in its stratum. If the video has made the
   shares of the lights very uneven, the stratum that spreads most is split, and the two neighbours that lose
   least by it are merged, for at most an eighth of the lights a call; lights that come of a split have a new
   id. A call with the same map and the same count as the call before leaves the lights as they are (except
   for the first call after ENVLT_METHOD_CDF, from which on these lights take mean directions).
   map          of the size and projection that envlt_create was given
   light_count  the number of lights wanted, 1..ENVLT_MAX_LIGHTS; 0 = as many as there are. If an earlier map
                had fewer lit texels than lights were wanted, as a nearly black sky does, 0 still wants that
                number: the first map with more lit texels builds all lights anew, with new ids. So a copy of
                the lights needs room for the number wanted, not for the number that came
   stats        may be NULL; receives what the call counted, on ENVLT_OK only
   Errors       those of envlt_create for the map, and these, after all of which the lights are as they were.
                ENVLT_ERR_ARGUMENT: lights is NULL, or light_count is above ENVLT_MAX_LIGHTS.
                ENVLT_ERR_MISMATCH: the map has another size or projection.
   Cost         time is O(texels + k^2), and for each split the time of the stratum's texels; memory
                meanwhile is 32 bytes a texel, 37 with split_sun, and 300 a light */

ENVLT_DEF void envlt_free(envlt_lights *lights);
/* Gives back the lights and their memory. NULL is allowed. */

ENVLT_DEF const char *envlt_result_text(envlt_result result);
/* Returns a constant string that says what a result means; "unknown result" for a number that is none. */

/* ---- memory, threads, progress, log: the caller's ---- */

typedef struct envlt_allocator {    /* all zero: malloc and free; else both functions */
    void *(*alloc_fn)(size_t bytes, void *user);    /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} envlt_allocator;

typedef void (*envlt_task)(void *context, size_t index);

typedef struct envlt_system {       /* all zero: malloc and free, this thread alone, no progress, no log */
    envlt_allocator allocator;      /* called from the thread that called us */
    void (*parallel_for)(void *user, size_t count, envlt_task task, void *context);
    /* Must call task(context, i) once for each i < count, in any order and on any threads, and return when
       all are done. What is computed does not depend on the threads. This header does not call parallel_for:
       it computes for milliseconds. */
    int (*progress)(void *user, float fraction);
    /* Called from the thread that called us, fraction 0..1 never falling within a call; not 0 cancels. This
       header does not call it. */
    void (*log)(void *user, const char *message);
    /* Called at most once by a call that fails, from the thread that called us, before it returns: one line
       without a line end that names the function, the field or element, its value and its range. */
    void *user;                     /* given to parallel_for, progress and log */
} envlt_system;

/* ---- settings and counts ---- */

typedef enum envlt_method {         /* how the map is cut into strata: "How it works" above */
    ENVLT_METHOD_DEFAULT,           /* = ENVLT_METHOD_VARIANCE, the best by measurement
                                       (docs/measured/envlights.md) */
    ENVLT_METHOD_STRUCTURED,        /* structured importance sampling, Agarwal et al. 2003. A cube map with
                                       fewer than 6 lights, the sun not counted, is cut by this method
                                       whatever you set */
    ENVLT_METHOD_MEDIAN_CUT,        /* median cut, Debevec 2005, for any number of lights */
    ENVLT_METHOD_VARIANCE,          /* minimum variance, after Viriyothai and Debevec 2009 */
    ENVLT_METHOD_CDF,               /* inversion of the cumulative distribution, the simplest of the four */
    ENVLT_METHOD_COUNT
} envlt_method;

#define ENVLT_MAX_LIGHTS 8192u      /* the most lights that envlt_create makes */

struct envlt_desc {                 /* zero it, then set what you care about */
    envlt_system system;
    uint32_t     light_count;       /* k, 1..ENVLT_MAX_LIGHTS; 0 = 128. There may be fewer lights, if the map
                                       has fewer lit texels or cuts fall into single texels or below the
                                       horizon: use the count of envlt_get_lights */
    envlt_method method;
    int          hemisphere;        /* not 0: only directions with y > 0 count */
    int          split_sun;         /* not 0: the brightest spot becomes light 0, with a stratum of its own,
                                       if the spot is smaller than 0.03 sr and has at least a light's share of
                                       the energy. If such a spot comes up in a later map, envlt_follow makes
                                       it light 0; if it goes out, light 0 keeps its place until a spot comes
                                       up again */
};

struct envlt_stats {                /* what envlt_create and envlt_follow counted */
    uint32_t lights;                /* how many lights there are now */
    uint32_t changed;               /* envlt_follow: how many lights have a new id */
    uint64_t bad_texels;            /* texels with a channel that is not finite, negative or above 1e30; such
                                       a channel counts as 0 */
    double   energy[3];             /* integral of radiance over all directions that count, W/m^2 */
    float    largest_move;          /* envlt_follow: the largest angle by which a light that kept its id
                                       turned, radians */
    float    mean_move;             /* the mean of these angles, weighted by energy */
    size_t   peak_bytes;            /* the most bytes that the allocator had given out at once */
};

/* ---- turning, jittering, matching ---- */

ENVLT_DEF envlt_result envlt_rotate(envlt_light *lights, uint32_t count, const float matrix[16]);
/* Turns directions and extents of lights with the environment (Knuth and Fuhrmann, section 3), in place. The
   lengths of extents do not change.
   matrix    a rotation: columns must be at right angles and of equal length within 1e-4, and of length 1
             within 1e-3
   Errors    this call has no log.
             ENVLT_ERR_ARGUMENT: matrix is NULL, or lights is NULL and count is not 0.
             ENVLT_ERR_INPUT: the matrix is not a rotation, or a light's direction is not unit. */

ENVLT_DEF envlt_result envlt_jitter(const envlt_lights *lights, uint32_t frame, uint32_t seed,
                                    envlt_light *out);
/* Writes the lights with other directions, each of them inside the light's stratum and chosen in proportion
   to luminance. Each frame has its own directions, by a low-discrepancy sequence, so that the mean of many
   frames tends to the exact picture. Energy is exact in each frame. Extents stay as they are, at right angles
   to the direction that the light had before.
   frame   the number of the frame
   seed    another seed gives other directions
   out     receives as many lights as there are
   Errors  ENVLT_ERR_ARGUMENT: lights or out is NULL. */

ENVLT_DEF envlt_result envlt_match(const envlt_light *previous, uint32_t previous_count, envlt_light *lights,
                                   uint32_t count);
/* Reorders the lights of a new build so that each stands where a previous light like it stood, with the same
   id, for maps that change their size or method. The previous lights, brightest first, give their place and
   id to the nearest light that is left. If there are more previous lights than new ones, the faintest
   previous lights are forgotten, and a light whose place is beyond count takes the place of a forgotten one.
   If there are fewer previous lights, the other new lights follow with new ids.
   Errors  this call has no log.
           ENVLT_ERR_ARGUMENT: an array is NULL and its count is not 0.
           ENVLT_ERR_INPUT: a light's direction is not unit.
   Cost    O(previous_count x count) */

/* ---- what a light stands for, and what all of them leave out ---- */

#define ENVLT_NO_LIGHT UINT32_MAX   /* stands for a texel that no light stands for: below the horizon with
                                       desc.hemisphere, or in a black map */

ENVLT_DEF const uint32_t *envlt_strata(const envlt_lights *lights, size_t *count);
/* Returns an array that has for each texel of the map the index of its light, or ENVLT_NO_LIGHT, and writes
   how many texels there are. The array is valid until the next envlt_follow or envlt_free.
   lights  NULL gives NULL and a count of 0
   count   may be NULL */

ENVLT_DEF envlt_result envlt_residual(const envlt_lights *lights, const envlt_map *map, float *rgb);
/* Writes the radiance of the map minus that of the lights, each light spread evenly over its stratum: what a
   renderer may add by other means, glossy or without shadows. The integral over every stratum is 0 in every
   channel.
   rgb     receives 3 floats a texel, negative ones too
   Errors  those of envlt_create for the map, and these.
           ENVLT_ERR_ARGUMENT: lights, map or rgb is NULL.
           ENVLT_ERR_MISMATCH: the map has another size or projection than that of the lights. */

ENVLT_DEF envlt_result envlt_residual_sh(const envlt_lights *lights, const envlt_map *map, float sh[27]);
/* Writes the radiance of the map minus that of the lights, each light at its direction, as 9 spherical
   harmonics for each channel. If you add envlt_sh_irradiance of them, shading without shadows is exact to
   that order.
   sh      receives sh[3 j + channel] for harmonic j. Harmonic 0 comes out as 0 but for rounding, since the
           lights have the energy of the map
   Errors  those of envlt_residual; ENVLT_ERR_ARGUMENT also if sh is NULL. */

ENVLT_DEF void envlt_sh_irradiance(const float sh[27], const float normal[3], float rgb[3]);
/* Writes the irradiance that radiance given as harmonics makes on a surface, W/m^2. It may be negative if the
   harmonics are those of a residual.
   normal  unit. This function returns no result and checks no length: the irradiance is that of the vector as
           it is */

/* ---- glTF ---- */

ENVLT_DEF size_t envlt_gltf_bytes(const envlt_light *lights, uint32_t count);
/* Returns the bytes that envlt_gltf_write needs, the zero at the end of the text included, or 0 if lights is
   NULL. */

ENVLT_DEF envlt_result envlt_gltf_write(const envlt_light *lights, uint32_t count, char *text, size_t bytes);
/* Writes a glTF 2.0 document with a node and a directional light of KHR_lights_punctual for each light, and a
   zero at the end of the text. Intensities are written in W/m^2, where glTF expects lux. Numbers that are not
   finite become 0.
   Errors  this call has no log.
           ENVLT_ERR_ARGUMENT: lights or text is NULL.
           ENVLT_ERR_INPUT: a light's direction is not unit.
           ENVLT_ERR_MEMORY: bytes is less than envlt_gltf_bytes returns. */

/* ---- texels of a map ---- */

ENVLT_DEF double envlt_texel_solid_angle(envlt_projection projection, uint32_t width, uint32_t height,
                                         uint32_t x, uint32_t y);
/* Returns the solid angle of texel x, y in steradians, exactly: all texels of a map add up to 4 pi. All
   faces of a cube have the same solid angles. Returns 0 for texels outside the map. */

ENVLT_DEF void envlt_texel_direction(envlt_projection projection, uint32_t width, uint32_t height,
                                     uint32_t face, float x, float y, float direction[3]);
/* Writes the unit direction towards the point x, y of a map.
   face    0..5 of a cube, else 0
   x, y    in texels from the top left corner: the centre of texel (i, j) is at (i + 0.5, j + 0.5). Beyond the
           map the point goes on round the sphere, or on the plane of the face, up to 8 times the map's size.
           A number that is not finite counts as 0 */

#ifdef __cplusplus
}
#endif

#endif /* ENVLIGHTS_H */

/* ==== src/envlights/begin.h ==== */

/* ==== implementation ==================================================================================== */

#if defined(ENVLIGHTS_IMPLEMENTATION) && !defined(ENVLIGHTS_IMPLEMENTED)
#define ENVLIGHTS_IMPLEMENTED

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
#define ENVLT__FINITE_MATH 1
#else
#define ENVLT__FINITE_MATH 0
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

typedef struct envlt__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} envlt__allocator;

static inline void *envlt__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void envlt__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
static inline int envlt__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

/* Returns 1 if the functions of a public allocator are both there or both NULL. */
static inline int envlt__allocator_valid(void *(*alloc_fn)(size_t, void *), void (*free_fn)(void *, void *))
{
    return (alloc_fn == NULL) == (free_fn == NULL);
}

static inline envlt__allocator envlt__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    envlt__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : envlt__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : envlt__default_free;
    a.user = user;
    return a;
}

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *envlt__alloc(const envlt__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *envlt__alloc_array(const envlt__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return envlt__mul_size(count, item_size, &size) ? envlt__alloc(a, size) : NULL;
}

static inline void envlt__free(const envlt__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/message.h ==== */

/* unit message: one line for the caller's log that says why a call failed */

/* ENVLT__COLD stands before functions that are needed only by calls that fail: compilers make these functions
   small, and take branches to them for unlikely. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define ENVLT__COLD __attribute__((cold))
#else
#define ENVLT__COLD
#endif

/* Where a message goes, and the name of the function that failed. If log is NULL, nothing is written. */
typedef struct envlt__logger {
    void (*log)(void *user, const char *message);
    void *user;
    const char *function;
} envlt__logger;

typedef struct envlt__message { char text[256]; size_t used; } envlt__message;

/* Appends a text; what does not fit is cut off. */
static inline ENVLT__COLD void envlt__message_text(envlt__message *m, const char *s)
{
    while (*s && m->used + 1 < sizeof m->text) m->text[m->used++] = *s++;
    m->text[m->used] = 0;
}

static inline ENVLT__COLD void envlt__message_count(envlt__message *m, uint64_t value)
{
    char digits[24];
    size_t at = sizeof digits - 1;
    digits[at] = 0;
    do digits[--at] = (char)('0' + (int)(value % 10));
    while ((value /= 10) != 0);
    envlt__message_text(m, digits + at);
}

/* Writes six significant digits without the zeros at their end. Returns how many digits are left and writes
   *exponent, the power of ten of the first one. value is finite and above 0. */
static inline ENVLT__COLD int envlt__message_digits(double value, char digits[8], int *exponent)
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
static inline ENVLT__COLD void envlt__message_number(envlt__message *m, double value)
{
    char digits[8], first[2] = { 0, 0 };
    int exponent, count, i;

    if (value != value) {
        envlt__message_text(m, "not a number");
        return;
    }
    if (value < 0.0) envlt__message_text(m, "-");
    if (value < 0.0) value = -value;
    if (!(value > 0.0) || value > 1.7976931348623157e308) {
        envlt__message_text(m, value > 0.0 ? "infinity" : "0");
        return;
    }
    if (value < 9007199254740992.0 && value - (double)(uint64_t)value <= 0.0) {
        envlt__message_count(m, (uint64_t)value);
        return;
    }
    count = envlt__message_digits(value, digits, &exponent);
    first[0] = digits[0];
    if (exponent < -4 || exponent > 9) {
        envlt__message_text(m, first);
        if (count > 1) envlt__message_text(m, ".");
        envlt__message_text(m, digits + 1);
        envlt__message_text(m, exponent < 0 ? "e-" : "e");
        envlt__message_count(m, (uint64_t)(exponent < 0 ? -exponent : exponent));
        return;
    }
    if (exponent < 0) envlt__message_text(m, "0.");
    for (i = exponent; i < -1; i++) envlt__message_text(m, "0");
    for (i = 0; i < count; i++) {
        if (exponent >= 0 && i == exponent + 1) envlt__message_text(m, ".");
        first[0] = digits[i];
        envlt__message_text(m, first);
    }
    for (i = count; i <= exponent; i++) envlt__message_text(m, "0");
}

/* Begins a line: "FUNCTION: FIELD". */
static inline ENVLT__COLD void envlt__message_begin(envlt__message *m,
                                          const envlt__logger *logger, const char *field)
{
    m->used = 0;
    envlt__message_text(m, logger->function);
    envlt__message_text(m, ": ");
    envlt__message_text(m, field);
}

/* Logs "FUNCTION: FIELD TEXT", as in "cohsm_build: mesh.positions is NULL". */
static inline ENVLT__COLD void envlt__log_text(const envlt__logger *logger, const char *field, const char *text)
{
    envlt__message m;
    if (!logger->log) return;
    envlt__message_begin(&m, logger, field);
    envlt__message_text(&m, " ");
    envlt__message_text(&m, text);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: FIELD is VALUE; it must be WANTED", as in "cohsm_build: desc.map_side is 3; it must be 0 or
   4..1024". */
static inline ENVLT__COLD void envlt__log_value(const envlt__logger *logger, const char *field, double value,
                                      const char *wanted)
{
    envlt__message m;
    if (!logger->log) return;
    envlt__message_begin(&m, logger, field);
    envlt__message_text(&m, " is ");
    envlt__message_number(&m, value);
    envlt__message_text(&m, "; it must be ");
    envlt__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* ==== src/shared/v3.h ==== */

/* unit v3: three floats */

/* tcc 0.9.27 stores a returned struct of 12 bytes as 16, over the caller's next variable. */
typedef struct envlt__v3 {
    float x, y, z;
#ifdef __TINYC__
    float unused;
#endif
} envlt__v3;

static inline envlt__v3 envlt__v3_make(float x, float y, float z)
{
    envlt__v3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

static inline envlt__v3 envlt__v3_load(const float *p) { return envlt__v3_make(p[0], p[1], p[2]); }
static inline void envlt__v3_store(float *p, envlt__v3 v) { p[0] = v.x; p[1] = v.y; p[2] = v.z; }

static inline envlt__v3 envlt__v3_add(envlt__v3 a, envlt__v3 b)
{
    return envlt__v3_make(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline envlt__v3 envlt__v3_sub(envlt__v3 a, envlt__v3 b)
{
    return envlt__v3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline envlt__v3 envlt__v3_scale(envlt__v3 a, float s)
{
    return envlt__v3_make(a.x * s, a.y * s, a.z * s);
}

static inline float envlt__v3_dot(envlt__v3 a, envlt__v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float envlt__v3_length(envlt__v3 a)
{
    return sqrtf(envlt__v3_dot(a, a));
}

static inline envlt__v3 envlt__v3_cross(envlt__v3 a, envlt__v3 b)
{
    return envlt__v3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/* Returns a with length 1. The largest component scales the others first, so that neither tiny nor huge
   vectors leave the range of floats. The zero vector stays zero. */
static inline envlt__v3 envlt__v3_normalize(envlt__v3 a)
{
    float x = fabsf(a.x), y = fabsf(a.y), z = fabsf(a.z), m = x > y ? x : y;
    m = m > z ? m : z;
    if (!(m > 0.0f)) return envlt__v3_make(0.0f, 0.0f, 0.0f);
    if (m < 1e-30f) {
        a = envlt__v3_scale(a, 1e30f);
        m *= 1e30f;
    }
    a = envlt__v3_make(a.x / m, a.y / m, a.z / m);
    m = envlt__v3_length(a);
    return envlt__v3_make(a.x / m, a.y / m, a.z / m);
}

/* Returns 1 if x is finite, by its exponent bits: under -ffast-math compilers may take isfinite() for always
   true. */
static inline int envlt__finite(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7f800000u) != 0x7f800000u;
}

static inline int envlt__v3_finite(envlt__v3 a)
{
    return envlt__finite(a.x) && envlt__finite(a.y) && envlt__finite(a.z);
}

/* Writes b1 and b2, which are orthonormal and right-handed together with a unit n; n.z may be -0 or -1. Duff
   et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017. */
static inline void envlt__v3_basis(envlt__v3 n, envlt__v3 *b1, envlt__v3 *b2)
{
    float s = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + n.z), b = n.x * n.y * a;
    *b1 = envlt__v3_make(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
    *b2 = envlt__v3_make(b, s + n.y * n.y * a, -n.y);
}

/* ==== src/shared/unit.h ==== */

/* unit unit: which vectors count as unit, the same in every header (src/README.md, "Unit vectors") */

/* The squares of the least and the greatest length that count as 1: an 8-bit normal map makes such
   vectors. */
#define ENVLT__UNIT_LEAST2 0.9409f       /* 0.97^2 */
#define ENVLT__UNIT_MOST2 1.0609f        /* 1.03^2 */

/* Says whether a vector is unit, by the square of its length. If that is not a number, the vector is not. */
static inline int envlt__is_unit2(float length2)
{
    return length2 >= ENVLT__UNIT_LEAST2 && length2 <= ENVLT__UNIT_MOST2;
}

/* ==== src/shared/m4.h ==== */

/* unit m4, needs v3: column-major 4 x 4 matrices, float[16], affine */

static inline envlt__v3 envlt__m4_direction(const float *m, envlt__v3 d)
{
    return envlt__v3_make(m[0] * d.x + m[4] * d.y + m[8] * d.z, m[1] * d.x + m[5] * d.y + m[9] * d.z,
                     m[2] * d.x + m[6] * d.y + m[10] * d.z);
}

/* Returns 1 if a matrix is finite and its last row is 0 0 0 1. */
static inline int envlt__m4_is_affine(const float *m)
{
    int i;
    for (i = 0; i < 16; i++)
        if (!envlt__finite(m[i])) return 0;
    return m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f && m[15] == 1.0f;
}

/* Returns 1 and writes *scale if m is a rotation times one scale > 0, without mirroring, and a translation.
   Its columns must be of equal length and at right angles within 1e-4, which products of float rotations
   reach. */
static inline int envlt__m4_is_rigid_uniform(const float *m, float *scale)
{
    envlt__v3 x = envlt__v3_load(m), y = envlt__v3_load(m + 4), z = envlt__v3_load(m + 8);
    float lx, ly, lz;
    float s, tolerance;

    if (!envlt__m4_is_affine(m)) return 0;
    lx = envlt__v3_length(x);
    ly = envlt__v3_length(y);
    lz = envlt__v3_length(z);
    if (!(lx > 0.0f && ly > 0.0f && lz > 0.0f) || !envlt__finite(lx + ly + lz)) return 0;
    s = (lx + ly + lz) / 3.0f;
    tolerance = 1e-4f * s;
    if (fabsf(lx - s) > tolerance || fabsf(ly - s) > tolerance || fabsf(lz - s) > tolerance) return 0;
    x = envlt__v3_scale(x, 1.0f / lx);
    y = envlt__v3_scale(y, 1.0f / ly);
    z = envlt__v3_scale(z, 1.0f / lz);
    if (fabsf(envlt__v3_dot(x, y)) > 1e-4f || fabsf(envlt__v3_dot(x, z)) > 1e-4f) return 0;
    if (fabsf(envlt__v3_dot(y, z)) > 1e-4f ||
        envlt__v3_dot(envlt__v3_cross(x, y), z) < 0.0f) return 0;
    *scale = s;
    return 1;
}

/* ==== src/shared/trig.h ==== */

/* unit trig: elementary functions with the same bits on every machine */

/* These functions use + - * / and sqrt alone, which IEEE 754 rounds the same everywhere as long as nothing
   is contracted (unit fp_begin). Coefficients are minimax fits of our own. The float functions are free of
   branches and calls, so that loops over them vectorise at SSE2 level. The errors named below are the
   largest differences from the double functions, over all float arguments or a dense set
   (tests/shared/units_test.c). Arguments out of range and NaN are clamped into the range, so that nothing
   here is undefined or returns NaN. */

static inline float envlt__from_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline uint32_t envlt__to_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* Returns |x| with the sign bit of s; s = -0 counts as negative. */
static inline float envlt__copysign(float x, float s)
{
    return envlt__from_bits((envlt__to_bits(x) & 0x7fffffffu) | (envlt__to_bits(s) & 0x80000000u));
}

/* Returns a if yes is 1 and b if it is 0, without a branch: compilers turn a chain of ?: with one condition
   into a branch, and then do not vectorise the loop round it. */
static inline float envlt__either(int yes, float a, float b)
{
    uint32_t mask = 0u - (uint32_t)yes;
    return envlt__from_bits((envlt__to_bits(a) & mask) | (envlt__to_bits(b) & ~mask));
}

/* Writes sine and cosine of |x| <= 8192 with an absolute error of 1e-7. As in Cody and Waite, pi/2 has three
   parts, of which the first two times k are exact for |k| < 2^13. */
static inline void envlt__sincos(float x, float *sine, float *cosine)
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

static inline float envlt__cos(float x)
{
    float s, c;
    envlt__sincos(x, &s, &c);
    return c;
}

/* Returns asin of 0 <= x <= 0.5, with z = x * x. The functions made of it have an absolute error of 3e-7. */
static inline float envlt__asin_core(float x, float z)
{
    return x + x * z * (0.1666675393f + z * (0.07495241769f + z * (0.04547709903f + z * (0.02414760004f +
                        z * 0.04221856856f))));
}

/* acos(x) is envlt__acos_rooted(x, sqrtf(envlt__acos_square(x))). The square root stands apart, since C compilers do
   not vectorise it. Above a half, asin(x) = pi/2 - 2 asin(sqrt((1 - x) / 2)) keeps acos exact near 0. */
static inline float envlt__acos_square(float x)
{
    float a = fabsf(x);
    return 0.5f * (1.0f - envlt__either(a < 1.0f, a, 1.0f));
}

static inline float envlt__acos_rooted(float x, float root)
{
    float a = fabsf(x), h = envlt__acos_square(x), p;
    int big = a > 0.5f;
    a = envlt__either(a < 1.0f, a, 1.0f);
    p = envlt__asin_core(envlt__either(big, root, a), envlt__either(big, h, a * a));
    p = envlt__either(big, 2.0f * p, 1.57079633f - p);
    return envlt__either(x < 0.0f, 3.14159265f - p, p);
}

static inline float envlt__acos(float x) { return envlt__acos_rooted(x, sqrtf(envlt__acos_square(x))); }

static inline float envlt__asin(float x)
{
    float a = fabsf(x), h, s, p;
    a = a < 1.0f ? a : 1.0f;
    h = 0.5f * (1.0f - a);
    s = sqrtf(h);
    s = a > 0.5f ? s : a;
    p = envlt__asin_core(s, a > 0.5f ? h : a * a);
    return envlt__copysign(a > 0.5f ? 1.57079633f - 2.0f * p : p, x);
}

/* ==== src/shared/rng.h ==== */

/* unit rng: hashes and random numbers, the same on every machine */

/* Returns a hash by the output function of O'Neill's PCG: Jarzynski and Olano, "Hash functions for GPU
   rendering", JCGT 9(3), 2020. */
static inline uint32_t envlt__hash32(uint32_t x)
{
    uint32_t state = x * 747796405u + 2891336453u;
    uint32_t word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

static inline uint32_t envlt__hash_combine(uint32_t a, uint32_t b)
{
    return envlt__hash32(a + 0x9e3779b9u * envlt__hash32(b));
}

/* Returns the upper 24 bits as a number in [0, 1). Every such value is a float; the largest is 1 - 2^-24. */
static inline float envlt__to_unit(uint32_t bits) { return (float)(bits >> 8) * (1.0f / 16777216.0f); }

/* ==== src/shared/cdf.h ==== */

/* unit cdf: piecewise-constant distributions in 1D and 2D, sampled by inversion */

/* A distribution over cells. sums[i] is the sum of the weights before cell i and sums[count] that of all;
   the array is the caller's. Sums are double, since a float sum of 1e6 small weights is wrong in the third
   digit. */
typedef struct envlt__cdf { const double *sums; uint32_t count; } envlt__cdf;

typedef struct envlt__cdf_sample {
    uint32_t index;
    float    fraction;      /* where u fell inside the cell, [0, 1): a fresh random number */
    float    probability;   /* of the cell; 0 only if all weights are 0 */
} envlt__cdf_sample;

static inline double envlt__cdf_total(const envlt__cdf *cdf) { return cdf->sums[cdf->count]; }

/* Returns the cell i with sums[i] <= u * total < sums[i + 1]. The strict upper bound keeps empty cells out,
   even at u = 0, and keeps the index in range for u below 1. u outside [0, 1) is clamped. */
static inline envlt__cdf_sample envlt__cdf_sample_at(const envlt__cdf *cdf, float u)
{
    envlt__cdf_sample s;
    double total = envlt__cdf_total(cdf), x, width, f;
    uint32_t lo = 0, hi = cdf->count;

    s.index = 0;
    s.fraction = 0.0f;
    s.probability = 0.0f;
    if (!(total > 0.0)) return s;
    if (!(u > 0.0f)) u = 0.0f;
    if (u > 0.99999994f) u = 0.99999994f;
    x = (double)u * total;
    while (hi - lo > 1u) {
        uint32_t mid = lo + (hi - lo) / 2u;
        if (cdf->sums[mid] <= x) lo = mid;
        else hi = mid;
    }
    /* This happens only if x was rounded up to a total of denormal size. */
    while (lo > 0 && !(cdf->sums[lo + 1u] > cdf->sums[lo])) lo--;
    width = cdf->sums[lo + 1u] - cdf->sums[lo];
    f = (x - cdf->sums[lo]) / width;
    s.index = lo;
    s.fraction = f < 0.99999994 ? (float)f : 0.99999994f;
    s.probability = (float)(width / total);
    return s;
}

/* ==== src/envlights/errors.h ==== */

/* ---- errors: results and what is logged of them ---- */

ENVLT_DEF const char *envlt_result_text(envlt_result result)
{
    static const char *const texts[] = {
#define ENVLT__TEXT(name, text) text,
        ENVLT_RESULTS(ENVLT__TEXT)
#undef ENVLT__TEXT
    };
    return (unsigned)result < ENVLT_RESULT_COUNT ? texts[result] : "unknown result";
}

static envlt__logger envlt__make_logger(const envlt_system *system, const char *function)
{
    envlt__logger logger;
    logger.log = system->log;
    logger.user = system->user;
    logger.function = function;
    return logger;
}

/* Logs that a field has a value which is out of its range, and returns the result. */
static envlt_result envlt__refuse(const envlt__logger *logger, const char *field, double value,
                                  const char *wanted, envlt_result result)
{
    envlt__log_value(logger, field, value, wanted);
    return result;
}

/* Returns the result of a call whose arguments were right, and logs if the allocator returned no memory. */
static envlt_result envlt__end_call(const envlt__logger *logger, envlt_result result)
{
    if (result == ENVLT_ERR_ALLOC) envlt__log_text(logger, "system.allocator", "returned no memory");
    return result;
}

/* Logs that a field is what the text says, as in "map is NULL", and returns the result. */
static envlt_result envlt__refuse_text(const envlt__logger *logger, const char *field, const char *text,
                                       envlt_result result)
{
    envlt__log_text(logger, field, text);
    return result;
}

/* ==== src/envlights/texels.h ==== */

/* ---- math: sine, cosine and arc tangent in double, the same bits everywhere ---- */

#define ENVLT__PI 3.14159265358979324

/* Writes sine and cosine of x, |x| <= 100. x is taken to an eighth of a turn about 0, with pi / 2 in two
   parts so that nothing cancels, and Taylor series of ten terms do the rest. */
static void envlt__sincos64(double x, double *sine, double *cosine)
{
    int k = (int)(x * (2.0 / ENVLT__PI) + (x < 0.0 ? -0.5 : 0.5)), j;
    double r = (x - (double)k * 1.5707963267948966) - (double)k * 6.123233995736766e-17, z = r * r, s = 1.0;
    double c = 1.0;
    for (j = 9; j > 0; j--) {
        s = 1.0 - s * z / (double)(2 * j * (2 * j + 1));
        c = 1.0 - c * z / (double)(2 * j * (2 * j - 1));
    }
    s *= r;
    *sine = k & 2 ? -(k & 1 ? c : s) : k & 1 ? c : s;
    *cosine = (k + 1) & 2 ? -(k & 1 ? s : c) : k & 1 ? s : c;
}

/* Returns the arc tangent. The angle is halved twice, by tan(a / 2) = tan a / (1 + sqrt(1 + tan^2 a)), so
   that the series converges quickly, and the result is four times the angle found. */
static double envlt__atan64(double x)
{
    double y = x / (1.0 + sqrt(1.0 + x * x)), z, sum = 0.0;
    int j;
    y = y / (1.0 + sqrt(1.0 + y * y));
    z = y * y;
    for (j = 21; j >= 0; j--) sum = 1.0 / (double)(2 * j + 1) - z * sum;
    return 4.0 * y * sum;
}

/* ---- texels: directions and solid angles ---- */

/* Returns the solid angle of the rectangle from the face's centre to (a, b), for a face at distance 1. */
static double envlt__corner_angle(double a, double b)
{
    return envlt__atan64(a * b / sqrt(1.0 + a * a + b * b));
}

/* Returns the solid angle of the rectangle [a0, a1] x [b0, b1] of a face at distance 1. */
static double envlt__rectangle_angle(double a0, double a1, double b0, double b1)
{
    return envlt__corner_angle(a1, b1) - envlt__corner_angle(a0, b1) - envlt__corner_angle(a1, b0) +
           envlt__corner_angle(a0, b0);
}

/* Returns the solid angle of a texel; with `upper` that of the part of the texel above the horizon. */
static double envlt__solid_angle(const envlt_map *map, uint32_t face, uint32_t x, uint32_t y, int upper)
{
    double w = map->width;
    double h = map->height;
    double c0, c1, s;
    double b0, b1;
    if (map->projection != ENVLT_PROJECTION_CUBE) {
        envlt__sincos64(ENVLT__PI * y / h, &s, &c0);
        envlt__sincos64(ENVLT__PI * (y + 1.0) / h, &s, &c1);
        if (upper && 2 * (uint64_t)y >= map->height) return 0.0;
        if (upper && 2 * ((uint64_t)y + 1) > map->height) c1 = 0.0;
        return 2.0 * ENVLT__PI / w * (c0 - c1);
    }
    b0 = 2.0 * y / h - 1.0;
    b1 = 2.0 * (y + 1.0) / h - 1.0;
    if (upper && face == 3) return 0.0;
    if (upper && face != 2) b1 = b1 > 0.0 ? 0.0 : b1;
    if (b0 >= b1) return 0.0;
    return envlt__rectangle_angle(2.0 * x / w - 1.0, 2.0 * (x + 1.0) / w - 1.0, b0, b1);
}

/* Writes the unit direction to the point (a, b) of a cube's face, both -1..1 from the face's top left corner.
   */
static void envlt__cube_direction(uint32_t face, double a, double b, double *d)
{
    double length = 1.0 / sqrt(1.0 + a * a + b * b);
    double x = face == 0 ? 1.0 : face == 1 ? -1.0 : face == 5 ? -a : a;
    double y = face == 2 ? 1.0 : face == 3 ? -1.0 : -b;
    double z = face == 0 ? -a : face == 1 ? a : face == 2 ? b : face == 3 ? -b : face == 4 ? 1.0 : -1.0;
    d[0] = x * length;
    d[1] = y * length;
    d[2] = z * length;
}

/* Writes the unit direction to the point (x, y) of the map, in texels from the top left corner of the face.
   */
static void envlt__direction(const envlt_map *map, uint32_t face, double x, double y, double *d)
{
    double st, ct, sp, cp;
    if (map->projection == ENVLT_PROJECTION_CUBE) {
        envlt__cube_direction(face, 2.0 * x / map->width - 1.0, 2.0 * y / map->height - 1.0, d);
        return;
    }
    envlt__sincos64(ENVLT__PI * y / map->height, &st, &ct);
    envlt__sincos64(2.0 * ENVLT__PI * (x / map->width - 0.5), &sp, &cp);
    d[0] = st * cp;
    d[1] = ct;
    d[2] = st * sp;
}

/* Returns the number of texel (x, y) of a cube's face. If x or y is one beyond the face, that is a texel of
   the neighbouring face. */
static uint32_t envlt__cube_texel(uint32_t side, uint32_t face, int64_t x, int64_t y)
{
    double d[3], m[3], a, b;
    double n = side;
    int64_t col = x, row = y;
    int i, axis = 0;
    if (x < 0 || y < 0 || x >= (int64_t)side || y >= (int64_t)side) {
        envlt__cube_direction(face, (2.0 * (double)x + 1.0) / n - 1.0, (2.0 * (double)y + 1.0) / n - 1.0, d);
        for (i = 0; i < 3; i++) {
            m[i] = fabs(d[i]);
            if (m[i] > m[axis]) axis = i;
        }
        face = (uint32_t)(2 * axis + (d[axis] < 0.0));
        a = face == 0 ? -d[2] : face == 1 ? d[2] : face == 5 ? -d[0] : d[0];
        b = face == 2 ? d[2] : face == 3 ? -d[2] : -d[1];
        col = (int64_t)((a / m[axis] + 1.0) * 0.5 * n);
        row = (int64_t)((b / m[axis] + 1.0) * 0.5 * n);
        col = col >= (int64_t)side ? (int64_t)side - 1 : col < 0 ? 0 : col;
        row = row >= (int64_t)side ? (int64_t)side - 1 : row < 0 ? 0 : row;
    }
    return (face * side + (uint32_t)row) * side + (uint32_t)col;
}

/* Checks whether a map can be used, and writes how many texels the map has. */
static envlt_result envlt__check_map(const envlt_map *map, size_t *texels, const envlt__logger *logger)
{
    uint64_t count;
    if (!map->rgb) return envlt__refuse_text(logger, "map.rgb", "is NULL", ENVLT_ERR_ARGUMENT);
    if (!map->width) return envlt__refuse(logger, "map.width", 0.0, "1 or more", ENVLT_ERR_ARGUMENT);
    if (!map->height) return envlt__refuse(logger, "map.height", 0.0, "1 or more", ENVLT_ERR_ARGUMENT);
    if (map->texel_stride && (map->texel_stride < 12 || map->texel_stride % 4))
        return envlt__refuse(logger, "map.texel_stride", (double)map->texel_stride,
                             "0, or a multiple of 4 from 12 on", ENVLT_ERR_ARGUMENT);
    if ((unsigned)map->projection >= ENVLT_PROJECTION_COUNT)
        return envlt__refuse(logger, "map.projection", map->projection, "one of envlt_projection",
                             ENVLT_ERR_INPUT);
    if (map->projection == ENVLT_PROJECTION_CUBE && map->width != map->height)
        return envlt__refuse(logger, "map.height", map->height, "the width: faces of a cube are squares",
                             ENVLT_ERR_ARGUMENT);
    count = map->width > 1u << 27 || map->height > 1u << 27 ? UINT64_MAX : (uint64_t)map->width * map->height;
    if (count <= 1u << 27 && map->projection == ENVLT_PROJECTION_CUBE) count *= 6u;
    if (count > 1u << 27)
        return envlt__refuse(logger, "map.width x map.height", (double)map->width * map->height,
                             "at most 2^27, all faces of a cube together", ENVLT_ERR_LIMIT);
    if (map->texel_stride && (size_t)count > SIZE_MAX / map->texel_stride)
        return envlt__refuse(logger, "map.texel_stride", (double)map->texel_stride,
                             "less: the map has more bytes than there are addresses", ENVLT_ERR_LIMIT);
    *texels = (size_t)count;
    return ENVLT_OK;
}

/* Reads the radiance of a texel with 0 in place of channels that are negative, above 1e30 or not a number,
   and returns 1 if there was such a channel. One comparison finds them all: read as integers, the bits of
   negative floats and of NaN are greater than those of 1e30 (0x7149f2ca), as are those of larger floats. The
   bits of -0 are too, but -0 is not counted. */
static inline int envlt__fetch_texel(const envlt_map *map, size_t texel, float *rgb)
{
    const char *p = (const char *)map->rgb + texel * (map->texel_stride ? map->texel_stride : 12);
    uint32_t bits[3];
    int c, bad = 0;
    memcpy(rgb, p, 3 * sizeof *rgb);
    memcpy(bits, p, sizeof bits);
    if (bits[0] <= 0x7149f2cau && bits[1] <= 0x7149f2cau && bits[2] <= 0x7149f2cau) return 0;
    for (c = 0; c < 3; c++)
        if (bits[c] > 0x7149f2cau) {
            bad |= (bits[c] & 0x7fffffffu) != 0;
            rgb[c] = 0.0f;
        }
    return bad;
}

static float envlt__luminance(const float *rgb)
{
    return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
}

ENVLT_DEF double envlt_texel_solid_angle(envlt_projection projection, uint32_t width, uint32_t height,
                                         uint32_t x, uint32_t y)
{
    envlt_map map;
    memset(&map, 0, sizeof map);
    map.projection = projection;
    map.width = width;
    map.height = height;
    return x < width && y < height ? envlt__solid_angle(&map, 0, x, y, 0) : 0.0;
}

/* Returns a coordinate within 8 times the map's size, for which sine and cosine are exact; 0 for NaN. */
static double envlt__clamp_coordinate(float x, uint32_t size)
{
    double most = 8.0 * size, d = envlt__finite(x) ? (double)x : 0.0;
    return d > most ? most : d < -most ? -most : d;
}

ENVLT_DEF void envlt_texel_direction(envlt_projection projection, uint32_t width, uint32_t height,
                                     uint32_t face, float x, float y, float direction[3])
{
    envlt_map map;
    double d[3];
    int i;
    memset(&map, 0, sizeof map);
    map.projection = projection;
    map.width = width ? width : 1;
    map.height = height ? height : 1;
    envlt__direction(&map, face, envlt__clamp_coordinate(x, map.width),
                     envlt__clamp_coordinate(y, map.height), d);
    for (i = 0; i < 3; i++) direction[i] = (float)d[i];
}

/* ==== src/envlights/grid.h ==== */

/* ---- grid: the map as weights, its columns turned so that the least energy comes first ---- */

typedef struct envlt__grid {
    envlt_map map;
    uint32_t  width, height, faces;
    uint32_t  roll;                         /* the column of the map that is column 0 of the grid */
    size_t    count;                        /* texels */
    float    *lum;                          /* luminance; 0 where a texel does not count or belongs to the
                                               sun */
    float    *omega;                        /* the solid angle that counts */
    float    *dx, *dy, *dz;                 /* unit directions, with azimuths counted from column 0 of the
                                               grid, so that a turned map has the same */
    double    total;                        /* the sum of luminance x solid angle */
    uint64_t  bad;                          /* texels with a channel that was replaced by 0 */
    float    *memory;                       /* of the five arrays */
} envlt__grid;

/* Returns the texel of the map for the grid's column x, in the row that begins at texel `row`. */
static size_t envlt__map_texel(const envlt__grid *g, size_t row, uint32_t x)
{
    return row + (x < g->width - g->roll ? x + g->roll : x + g->roll - g->width);
}

/* Fills in the directions of the texels' centres. */
static void envlt__fill_directions(envlt__grid *g)
{
    uint32_t f, x, y;
    double d[3];
    double st, ct, sp, cp;
    size_t t = 0;
    if (g->faces == 6) {
        for (f = 0; f < 6; f++)
            for (y = 0; y < g->height; y++)
                for (x = 0; x < g->width; x++, t++) {
                    envlt__direction(&g->map, f, x + 0.5, y + 0.5, d);
                    g->dx[t] = (float)d[0];
                    g->dy[t] = (float)d[1];
                    g->dz[t] = (float)d[2];
                }
        return;
    }
    /* The first row holds the azimuths until it is made itself, last. */
    for (x = 0; x < g->width; x++) {
        envlt__sincos64(2.0 * ENVLT__PI * (x + 0.5) / g->width, &sp, &cp);
        g->dx[x] = (float)cp;
        g->dz[x] = (float)sp;
    }
    for (y = g->height; y-- > 0;) {
        envlt__sincos64(ENVLT__PI * (y + 0.5) / g->height, &st, &ct);
        t = (size_t)y * g->width;
        for (x = 0; x < g->width; x++) {
            g->dx[t + x] = (float)st * g->dx[x];
            g->dy[t + x] = (float)ct;
            g->dz[t + x] = (float)st * g->dz[x];
        }
    }
}

/* Chooses the column with the least energy for column 0 of the grid, so that turning a latitude-longitude map
   turns its lights (T21). sums is an array of width zeros. */
static void envlt__choose_roll(envlt__grid *g, double *sums, int hemisphere)
{
    uint32_t x, y;
    float rgb[3];
    for (y = 0; y < g->height; y++) {
        double omega = envlt__solid_angle(&g->map, 0, 0, y, hemisphere);
        for (x = 0; omega > 0.0 && x < g->width; x++) {
            envlt__fetch_texel(&g->map, (size_t)y * g->width + x, rgb);
            sums[x] += (double)envlt__luminance(rgb) * omega;
        }
    }
    for (x = 0; x < g->width; x++)
        if (sums[x] < sums[g->roll]) g->roll = x;
}

/* Fills in luminance and solid angle of each texel, and their sums. */
static void envlt__fill_weights(envlt__grid *g, int hemisphere)
{
    uint32_t f, x, y;
    size_t t = 0;
    float rgb[3];
    for (f = 0; f < g->faces; f++)
        for (y = 0; y < g->height; y++) {
            double row = 0.0, omega = g->faces == 1 ? envlt__solid_angle(&g->map, 0, 0, y, hemisphere) : 0.0;
            for (x = 0; x < g->width; x++, t++) {
                if (g->faces == 6) omega = envlt__solid_angle(&g->map, f, x, y, hemisphere);
                g->omega[t] = (float)omega;
                g->lum[t] = 0.0f;
                if (!(omega > 0.0)) continue;
                g->bad += (uint64_t)envlt__fetch_texel(&g->map, envlt__map_texel(g, t - x, x), rgb);
                g->lum[t] = envlt__luminance(rgb);
                row += (double)g->lum[t] * omega;
            }
            g->total += row;
        }
}

/* Fills the grid from a map that envlt__check_map has passed. roll is the map's column for column 0 of the
   grid, or ENVLT_NO_LIGHT for the column with the least energy. */
static envlt_result envlt__make_grid(envlt__grid *g, const envlt_map *map, int hemisphere, uint32_t roll,
                                     const envlt__allocator *a)
{
    double *sums;
    size_t t, count = (size_t)map->width * map->height * (map->projection == ENVLT_PROJECTION_CUBE ? 6 : 1);
    memset(g, 0, sizeof *g);
    g->map = *map;
    g->width = map->width;
    g->height = map->height;
    g->faces = map->projection == ENVLT_PROJECTION_CUBE ? 6 : 1;
    g->count = count;
    g->roll = roll == ENVLT_NO_LIGHT ? 0 : roll;
    if (g->faces == 1 && roll == ENVLT_NO_LIGHT) {
        sums = (double *)envlt__alloc_array(a, g->width, sizeof *sums);
        if (!sums) return ENVLT_ERR_ALLOC;
        for (t = 0; t < g->width; t++) sums[t] = 0.0;
        envlt__choose_roll(g, sums, hemisphere);
        envlt__free(a, sums);
    }
    g->memory = (float *)envlt__alloc_array(a, g->count, 5 * sizeof(float));
    if (!g->memory) return ENVLT_ERR_ALLOC;
    g->lum = g->memory;
    g->omega = g->lum + count;
    g->dx = g->omega + count;
    g->dy = g->dx + count;
    g->dz = g->dy + count;
    envlt__fill_directions(g);
    envlt__fill_weights(g, hemisphere);
    return ENVLT_OK;
}

/* Returns the energy of a texel, luminance x solid angle. */
static double envlt__texel_weight(const envlt__grid *g, size_t t)
{
    return (double)g->lum[t] * (double)g->omega[t];
}

static double envlt__sum_weights(const envlt__grid *g)
{
    double total = 0.0;
    size_t t;
    for (t = 0; t < g->count; t++) total += envlt__texel_weight(g, t);
    return total;
}

/* Writes the four neighbours of a texel. They go round the seam and over the poles of a latitude-longitude
   map, and across the edges of a cube. */
static void envlt__neighbours(const envlt__grid *g, uint32_t t, uint32_t *out)
{
    uint32_t w = g->width;
    uint32_t h = g->height;
    uint32_t x = t % w;
    uint32_t row = t / w;
    uint32_t y = row % h;
    uint32_t face = row / h;
    if (g->faces == 6) {
        out[0] = x > 0 ? t - 1 : envlt__cube_texel(w, face, -1, (int64_t)y);
        out[1] = x + 1 < w ? t + 1 : envlt__cube_texel(w, face, (int64_t)w, (int64_t)y);
        out[2] = y > 0 ? t - w : envlt__cube_texel(w, face, (int64_t)x, -1);
        out[3] = y + 1 < h ? t + w : envlt__cube_texel(w, face, (int64_t)x, (int64_t)h);
        return;
    }
    out[0] = x > 0 ? t - 1 : t + w - 1;
    out[1] = x + 1 < w ? t + 1 : t + 1 - w;
    out[2] = y > 0 ? t - w : row * w + (x + w / 2) % w;
    out[3] = y + 1 < h ? t + w : row * w + (x + w / 2) % w;
}

/* ==== src/envlights/structured.h ==== */

/* ---- structured: structured importance sampling ---- */

/* Agarwal, Ramamoorthi, Belongie and Jensen, "Structured importance sampling of environment maps", SIGGRAPH
   2003. Thresholds i sigma, i = 5 .. 0, cut the map into layers. From the brightest layer down, each
   connected region of energy L and solid angle w gets N L min(w, w0)^(1/4) / (L_all w0^(1/4)) samples. w0 is
   0.01 sr: across more than that, visibility is as good as uncorrelated, so that a larger size counts no
   more. Samples that the region holds from brighter layers count among its samples; the others are spread by
   Hochbaum and Shmoys' farthest-first traversal. A texel belongs to the nearest sample of the innermost
   region that got samples of its own. */
#define ENVLT__LAYERS 6u
#define ENVLT__BLOCK 8u             /* texels a side of a block, by which distances are skipped */
#define ENVLT__FROZEN 0x80u         /* bit of a texel's layer: its sample does not change any more */
#define ENVLT__SAMPLE 0x40u         /* bit of a texel's layer: the texel is a sample itself */

typedef struct envlt__block {
    float    center[3], radius;             /* the cone that holds the directions of its texels */
    float    skip;                          /* a sample whose cosine to the centre is this or less changes no
                                               texel of the block */
    float    worst;                         /* the least cosine of a candidate to its sample */
    uint32_t worst_texel;
    uint32_t face;
    uint32_t x0, y0, x1, y1;
} envlt__block;

typedef struct envlt__structured {
    const envlt__grid *g;
    float        *best;                     /* cosine to the nearest sample of the region at hand */
    uint32_t     *label, *owner, *queue;    /* owner is the region that a texel is in */
    uint8_t      *layer;
    uint32_t     *sample;                   /* the texel of each sample */
    uint32_t      count, wanted, region;
    envlt__block *blocks;
    uint32_t      block_count, blocks_wide, blocks_high;
} envlt__structured;

/* Divides the grid into blocks and finds the cone of each. */
static void envlt__make_blocks(envlt__structured *s)
{
    const envlt__grid *g = s->g;
    uint32_t b, x, y;
    for (b = 0; b < s->block_count; b++) {
        envlt__block *k = &s->blocks[b];
        envlt__v3 sum = envlt__v3_make(0, 0, 0);
        float least = 1.0f, c;
        k->face = b / (s->blocks_wide * s->blocks_high);
        k->x0 = b % s->blocks_wide * ENVLT__BLOCK;
        k->y0 = b / s->blocks_wide % s->blocks_high * ENVLT__BLOCK;
        k->x1 = k->x0 + ENVLT__BLOCK < g->width ? k->x0 + ENVLT__BLOCK : g->width;
        k->y1 = k->y0 + ENVLT__BLOCK < g->height ? k->y0 + ENVLT__BLOCK : g->height;
        for (y = k->y0; y < k->y1; y++)
            for (x = k->x0; x < k->x1; x++) {
                size_t t = ((size_t)k->face * g->height + y) * g->width + x;
                sum = envlt__v3_add(sum, envlt__v3_make(g->dx[t], g->dy[t], g->dz[t]));
            }
        sum = envlt__v3_normalize(sum);
        envlt__v3_store(k->center, sum);
        for (y = k->y0; y < k->y1; y++)
            for (x = k->x0; x < k->x1; x++) {
                size_t t = ((size_t)k->face * g->height + y) * g->width + x;
                c = sum.x * g->dx[t] + sum.y * g->dy[t] + sum.z * g->dz[t];
                if (c < least) least = c;
            }
        k->radius = envlt__acos(least) + 1e-3f;
    }
}

/* Compares the sample with every texel of the block, then finds which candidate is farthest from its sample,
   and how far away a further sample has no effect. A texel that is a sample itself, or no candidate, has best
   = 2. */
static void envlt__update_block(const envlt__structured *s, envlt__block *k, uint32_t id)
{
    const envlt__grid *g = s->g;
    uint32_t at = s->sample[id], y;
    float cx = g->dx[at];
    float cy = g->dy[at];
    float cz = g->dz[at];
    float farthest = 2.0f;
    float reach;
    k->worst = 2.0f;
    for (y = k->y0; y < k->y1; y++) {
        size_t row = ((size_t)k->face * g->height + y) * g->width, t;
        for (t = row + k->x0; t < row + k->x1; t++) {
            float d = cx * g->dx[t] + cy * g->dy[t] + cz * g->dz[t], best = s->best[t];
            if (d > best) {
                s->best[t] = best = d;
                s->label[t] = id;
            }
            if (best < farthest) farthest = best;
            if (best < k->worst && g->lum[t] > 0.0f) {
                k->worst = best;
                k->worst_texel = (uint32_t)t;
            }
        }
    }
    reach = (farthest > 1.0f ? 0.0f : envlt__acos(farthest)) + k->radius;
    k->skip = farthest > 1.5f ? 2.0f : reach < 3.14f ? envlt__cos(reach) - 1e-5f : -2.0f;
}

/* Updates all blocks in which the new sample may be the nearest of some texel. */
static void envlt__add_sample(envlt__structured *s, uint32_t id)
{
    const envlt__grid *g = s->g;
    uint32_t at = s->sample[id], b;
    for (b = 0; b < s->block_count; b++) {
        envlt__block *k = &s->blocks[b];
        if (g->dx[at] * k->center[0] + g->dy[at] * k->center[1] + g->dz[at] * k->center[2] > k->skip)
            envlt__update_block(s, k, id);
    }
}

/* Returns whether the region has an earlier sample within two degrees. Samples of brighter layers that crowd
   together count as one outside their own region: else each of the hundred samples of a sun would be compared
   with the whole sky. */
static int envlt__has_twin(const envlt__structured *s, uint32_t id)
{
    const envlt__grid *g = s->g;
    uint32_t a = s->sample[id], b, i;
    for (i = 0; i < id; i++) {
        b = s->sample[i];
        if (s->owner[b] != s->region) continue;
        if (g->dx[a] * g->dx[b] + g->dy[a] * g->dy[b] + g->dz[a] * g->dz[b] > 0.99939f) return 1;
    }
    return 0;
}

/* Spreads fresh samples, farthest first, over the region whose texels are queue[0..size), or over all texels
   if size is 0. brightest is where the first sample goes if there is none yet. */
static void envlt__spread_samples(envlt__structured *s, uint32_t size, uint32_t brightest, uint32_t fresh)
{
    uint32_t i, b;
    uint32_t n = size ? size : (uint32_t)s->g->count;
    uint32_t before = s->count;
    uint32_t last = before + fresh;
    for (b = 0; b < s->block_count; b++) s->blocks[b].skip = size ? 2.0f : -2.0f;
    for (b = 0; b < s->block_count; b++) s->blocks[b].worst = 2.0f;
    for (i = 0; i < n; i++) {
        uint32_t t = size ? s->queue[i] : i, row = t / s->g->width;
        uint32_t y = row % s->g->height / ENVLT__BLOCK, face = row / s->g->height;
        if (s->layer[t] & ENVLT__FROZEN) continue;
        s->best[t] = -2.0f;
        if (size)
            s->blocks[(face * s->blocks_high + y) * s->blocks_wide +
                      t % s->g->width / ENVLT__BLOCK].skip = -2.0f;
    }
    for (i = 0; i < before; i++)
        if (s->owner[s->sample[i]] == s->region && !envlt__has_twin(s, i)) envlt__add_sample(s, i);
    while (s->count < last) {
        uint32_t at = brightest;
        float worst = 2.0f;
        for (b = 0; b < s->block_count; b++)
            if (s->blocks[b].worst < worst) {
                worst = s->blocks[b].worst;
                at = s->blocks[b].worst_texel;
            }
        if (worst > 1.5f && (s->count > before || s->layer[at] & ENVLT__FROZEN)) break;
        s->sample[s->count] = at;
        s->layer[at] |= ENVLT__SAMPLE;
        s->best[at] = 2.0f;
        s->label[at] = s->count;
        envlt__add_sample(s, s->count++);
    }
    for (i = 0; i < n; i++) {
        s->layer[size ? s->queue[i] : i] |= ENVLT__FROZEN;
        s->best[size ? s->queue[i] : i] = 2.0f;
    }
}

/* Fills the queue with the connected region of texels in this layer or above round the seed, and returns its
   size. */
static uint32_t envlt__flood_region(envlt__structured *s, uint32_t seed, uint32_t layer, double *energy,
                                    double *omega, uint32_t *samples, uint32_t *brightest)
{
    uint32_t head = 0, tail = 0, next[4], i;
    float most = -1.0f;
    *energy = *omega = 0.0;
    *samples = 0;
    s->queue[tail++] = seed;
    s->owner[seed] = s->region;
    while (head < tail) {
        uint32_t t = s->queue[head++];
        *energy += envlt__texel_weight(s->g, t);
        *omega += (double)s->g->omega[t];
        *samples += (s->layer[t] & ENVLT__SAMPLE) != 0;
        if (s->g->lum[t] > most && !(s->layer[t] & ENVLT__FROZEN)) {
            most = s->g->lum[t];
            *brightest = t;
        }
        envlt__neighbours(s->g, t, next);
        for (i = 0; i < 4; i++)
            if ((s->layer[next[i]] & 15u) >= layer && s->owner[next[i]] != s->region) {
                s->owner[next[i]] = s->region;
                s->queue[tail++] = next[i];
            }
    }
    return tail;
}

/* Sorts texels into layers by luminance, and writes the solid angle of all of them. */
static void envlt__make_layers(envlt__structured *s, double *all_omega)
{
    const envlt__grid *g = s->g;
    double mean, variance = 0.0, omega = 0.0, sigma;
    size_t t;
    for (t = 0; t < g->count; t++) omega += (double)g->omega[t];
    mean = omega > 0.0 ? g->total / omega : 0.0;
    for (t = 0; t < g->count; t++) {
        double d = (double)g->lum[t] - mean;
        variance += d * d * (double)g->omega[t];
    }
    sigma = omega > 0.0 ? sqrt(variance / omega) : 0.0;
    for (t = 0; t < g->count; t++) {
        uint32_t i = 0;
        while (i + 1 < ENVLT__LAYERS && sigma > 0.0 && (double)g->lum[t] >= (i + 1) * sigma) i++;
        s->layer[t] = (uint8_t)i;
        s->owner[t] = 0;
        s->label[t] = ENVLT_NO_LIGHT;
        s->best[t] = 2.0f;
    }
    *all_omega = omega;
}

/* Returns the importance of a region, by which samples are shared out: see the head of this part. */
static double envlt__importance(double energy, double omega)
{
    return energy * sqrt(sqrt(omega < 0.01 ? omega : 0.01));
}

/* Places all samples: layer by layer from the brightest down, then what is left of them over the whole map.
   */
static void envlt__run_structured(envlt__structured *s)
{
    const envlt__grid *g = s->g;
    double all, energy, omega;
    uint32_t layer, samples;
    uint32_t brightest = 0;
    uint32_t size, fresh;
    size_t t, first = 0;

    envlt__make_layers(s, &omega);
    envlt__make_blocks(s);
    all = envlt__importance(g->total, omega);
    for (layer = ENVLT__LAYERS - 1; layer > 0; layer--) {
        uint32_t oldest = s->region + 1;
        for (t = 0; t < g->count; t++) {
            double share;
            if ((s->layer[t] & 15u) < layer || s->owner[t] >= oldest) continue;
            s->region++;
            size = envlt__flood_region(s, (uint32_t)t, layer, &energy, &omega, &samples, &brightest);
            share = (double)s->wanted * envlt__importance(energy, omega) / all + 0.5;
            fresh = share > samples + 1.0 ? (uint32_t)share - samples : 0;
            if (fresh > s->wanted - s->count) fresh = s->wanted - s->count;
            if (fresh && !(s->layer[brightest] & ENVLT__FROZEN))
                envlt__spread_samples(s, size, brightest, fresh);
        }
    }
    s->region++;
    for (t = 0; t < g->count; t++) {
        if (!(g->omega[t] > 0.0f)) s->layer[t] |= ENVLT__FROZEN;
        else if (!(s->layer[t] & ENVLT__FROZEN) &&
                 (s->layer[first] & ENVLT__FROZEN || g->lum[t] > g->lum[first]))
            first = t;
        s->owner[t] = s->region;
    }
    envlt__spread_samples(s, 0, (uint32_t)first, s->wanted - s->count);
}

/* Returns the first texel of the row of averages that holds row y of the grid, faces counted through. */
static size_t envlt__coarse_row(const envlt__grid *g, const envlt__grid *coarse, uint32_t factor, uint32_t y)
{
    return ((size_t)(y / g->height) * coarse->height + y % g->height / factor) * coarse->width;
}

/* Makes a grid of averages over factor x factor texels, fewer at the edges. Returns 0 if there is no memory.
   */
static int envlt__coarsen_grid(const envlt__grid *g, uint32_t factor, envlt__grid *out,
                               const envlt__allocator *a)
{
    uint32_t x, y, left;
    size_t t = 0, i;
    *out = *g;
    out->width = (g->width + factor - 1) / factor;
    out->height = (g->height + factor - 1) / factor;
    out->count = (size_t)out->width * out->height * g->faces;
    out->memory = (float *)envlt__alloc_array(a, out->count, 5 * sizeof(float));
    if (!out->memory) return 0;
    out->lum = out->memory;
    out->omega = out->lum + out->count;
    out->dx = out->omega + out->count;
    out->dy = out->dx + out->count;
    out->dz = out->dy + out->count;
    memset(out->memory, 0, 5 * out->count * sizeof(float));
    for (y = 0; y < g->height * g->faces; y++) {
        i = envlt__coarse_row(g, out, factor, y);
        for (x = 0, left = factor; x < g->width; x++, t++) {
            out->lum[i] += (float)envlt__texel_weight(g, t);
            out->omega[i] += g->omega[t];
            out->dx[i] += g->dx[t];
            out->dy[i] += g->dy[t];
            out->dz[i] += g->dz[t];
            if (--left) continue;
            left = factor;
            i++;
        }
    }
    for (i = 0; i < out->count; i++) {
        envlt__v3 d = envlt__v3_normalize(envlt__v3_make(out->dx[i], out->dy[i], out->dz[i]));
        if (out->omega[i] > 0.0f) out->lum[i] /= out->omega[i];
        out->dx[i] = d.x;
        out->dy[i] = d.y;
        out->dz[i] = d.z;
    }
    return 1;
}

/* Labels texels by structured sampling. A map of more than 2^17 texels is first reduced to averages of about
   half a degree, which is far below the distance of samples. */
static envlt_result envlt__label_structured(const envlt__grid *g, uint32_t k, uint32_t *label,
                                            const envlt__allocator *a)
{
    envlt__structured s;
    envlt__grid coarse;
    envlt_result result = ENVLT_ERR_ALLOC;
    uint32_t factor = 1, x, y, left;
    size_t t = 0;
    while (g->count / factor / factor > 131072u) factor++;
    memset(&s, 0, sizeof s);
    if (!envlt__coarsen_grid(g, factor, &coarse, a)) return result;
    s.g = &coarse;
    s.wanted = k;
    s.blocks_wide = (coarse.width + ENVLT__BLOCK - 1) / ENVLT__BLOCK;
    s.blocks_high = (coarse.height + ENVLT__BLOCK - 1) / ENVLT__BLOCK;
    s.block_count = s.blocks_wide * s.blocks_high * coarse.faces;
    s.best = (float *)envlt__alloc_array(a, coarse.count, sizeof *s.best);
    s.label = (uint32_t *)envlt__alloc_array(a, coarse.count, sizeof *s.label);
    s.owner = (uint32_t *)envlt__alloc_array(a, coarse.count, sizeof *s.owner);
    s.queue = (uint32_t *)envlt__alloc_array(a, coarse.count, sizeof *s.queue);
    s.layer = (uint8_t *)envlt__alloc(a, coarse.count);
    s.sample = (uint32_t *)envlt__alloc_array(a, k, sizeof *s.sample);
    s.blocks = (envlt__block *)envlt__alloc_array(a, s.block_count, sizeof *s.blocks);
    if (s.best && s.label && s.owner && s.queue && s.layer && s.sample && s.blocks) {
        envlt__run_structured(&s);
        for (y = 0; y < g->height * g->faces; y++) {
            const uint32_t *row = s.label + envlt__coarse_row(g, &coarse, factor, y);
            for (x = 0, left = factor; x < g->width; x++) {
                label[t++] = *row;
                if (--left) continue;
                left = factor;
                row++;
            }
        }
        result = ENVLT_OK;
    }
    envlt__free(a, s.blocks);
    envlt__free(a, s.sample);
    envlt__free(a, s.layer);
    envlt__free(a, s.queue);
    envlt__free(a, s.owner);
    envlt__free(a, s.label);
    envlt__free(a, s.best);
    envlt__free(a, coarse.memory);
    return result;
}

/* ==== src/envlights/regions.h ==== */

/* ---- regions: median cut, minimum variance and inversion, all by summed-area tables ---- */

/* The sum over some texels of w = luminance x solid angle, and the sum of w times the texel's direction. */
typedef struct envlt__moments { double w, x, y, z; } envlt__moments;

typedef struct envlt__region {
    uint32_t face;
    uint32_t x0, y0, x1, y1;
    uint32_t lights;                /* of median cut: how many lights the region is to become */
    uint32_t cut_x, cut_y;          /* of variance: the column or row of the best cut; both 0: there is none
                                       */
    double   gain, rank;            /* the scatter that the cut takes away; the region of highest rank is cut
                                       first */
    envlt__moments sum;
} envlt__region;

/* Fills the summed-area table of (width + 1) x (height + 1) entries a face. Entry (x, y) holds the sum over
   all texels of the face with a lower column than x and a lower row than y. */
static void envlt__fill_table(const envlt__grid *g, envlt__moments *table)
{
    uint32_t f, x, y;
    size_t t = 0, stride = (size_t)g->width + 1;
    for (f = 0; f < g->faces; f++, table += stride * ((size_t)g->height + 1)) {
        memset(table, 0, stride * sizeof *table);
        for (y = 0; y < g->height; y++) {
            const envlt__moments *above = table + y * stride;
            envlt__moments *here = table + (y + 1) * stride, row = { 0, 0, 0, 0 };
            here[0] = row;
            for (x = 0; x < g->width; x++, t++) {
                double w = envlt__texel_weight(g, t);
                row.w += w;
                row.x += w * (double)g->dx[t];
                row.y += w * (double)g->dy[t];
                row.z += w * (double)g->dz[t];
                here[x + 1].w = above[x + 1].w + row.w;
                here[x + 1].x = above[x + 1].x + row.x;
                here[x + 1].y = above[x + 1].y + row.y;
                here[x + 1].z = above[x + 1].z + row.z;
            }
        }
    }
}

/* Fills a table of the energy alone. Median cut and inversion need no directions, and they are faster with a
   quarter of the memory. */
static void envlt__fill_energy(const envlt__grid *g, double *table)
{
    uint32_t f, x, y;
    size_t t = 0, stride = (size_t)g->width + 1;
    for (f = 0; f < g->faces; f++, table += stride * ((size_t)g->height + 1)) {
        memset(table, 0, stride * sizeof *table);
        for (y = 0; y < g->height; y++) {
            const double *above = table + y * stride;
            double *here = table + (y + 1) * stride, row = 0.0;
            here[0] = row;
            for (x = 0; x < g->width; x++, t++) {
                row += envlt__texel_weight(g, t);
                here[x + 1] = above[x + 1] + row;
            }
        }
    }
}

/* Returns the energy of the columns x0..x1 and rows y0..y1, ends excluded, of the region's face. */
static double envlt__area_energy(const envlt__grid *g, const double *table, const envlt__region *r,
                                 uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1)
{
    size_t stride = (size_t)g->width + 1;
    const double *top = table + stride * ((size_t)g->height + 1) * r->face + y0 * stride;
    const double *bottom = top + (y1 - y0) * stride;
    return (bottom[x1] - top[x1]) - (bottom[x0] - top[x0]);
}

/* Returns the moments of the columns x0..x1 and rows y0..y1, ends excluded, of the region's face. */
static envlt__moments envlt__area_moments(const envlt__grid *g, const envlt__moments *table,
                                          const envlt__region *r, uint32_t x0, uint32_t y0, uint32_t x1,
                                          uint32_t y1)
{
    size_t stride = (size_t)g->width + 1;
    const envlt__moments *t = table + stride * ((size_t)g->height + 1) * r->face;
    const envlt__moments *a = t + y0 * stride + x0, *b = t + y0 * stride + x1;
    const envlt__moments *c = t + y1 * stride + x0, *d = t + y1 * stride + x1;
    envlt__moments m;
    m.w = (d->w - b->w) - (c->w - a->w);
    m.x = (d->x - b->x) - (c->x - a->x);
    m.y = (d->y - b->y) - (c->y - a->y);
    m.z = (d->z - b->z) - (c->z - a->z);
    return m;
}

/* Returns the sum of w |d - mean|^2, which is w - |sum of w d|^2 / w, since directions have length 1. */
static double envlt__squared_spread(const envlt__moments *m)
{
    double s = m->w > 0.0 ? m->w - (m->x * m->x + m->y * m->y + m->z * m->z) / m->w : 0.0;
    return s > 0.0 ? s : 0.0;
}

/* Takes a cut for the region's best if it takes more scatter away than the best so far. `left` are the
   moments of one half, `whole` is the scatter of the region, `least` the energy that each half must exceed.
   */
static void envlt__try_cut(envlt__region *r, const envlt__moments *left, double whole, double least,
                           uint32_t x, uint32_t y)
{
    envlt__moments right;
    double gain;
    right.w = r->sum.w - left->w;
    right.x = r->sum.x - left->x;
    right.y = r->sum.y - left->y;
    right.z = r->sum.z - left->z;
    if (!(left->w > least) || !(right.w > least)) return;         /* no cut may make an empty half */
    gain = whole - envlt__squared_spread(left) - envlt__squared_spread(&right);
    if (gain <= r->gain) return;
    r->gain = gain;
    r->cut_x = x;
    r->cut_y = y;
}

/* Finds the cut of a region that leaves the least scatter: Viriyothai and Debevec, "Variance minimization
   light probe sampling", 2009. Which region is cut next is our own choice, since by gain alone a sun is never
   cut (docs/envlights.md). The rank is w^3 gain; its fourth root is w (gain / w)^(1/4), the importance of
   Agarwal et al. with the gain per energy in place of the solid angle. */
static void envlt__best_cut(const envlt__grid *g, const envlt__moments *table, envlt__region *r)
{
    double whole, least;
    uint32_t i;
    r->sum = envlt__area_moments(g, table, r, r->x0, r->y0, r->x1, r->y1);
    r->gain = -1.0;
    r->cut_x = r->cut_y = 0;
    whole = envlt__squared_spread(&r->sum);
    least = 1e-12 * r->sum.w;
    for (i = r->x0 + 1; i < r->x1; i++) {
        envlt__moments left = envlt__area_moments(g, table, r, r->x0, r->y0, i, r->y1);
        envlt__try_cut(r, &left, whole, least, i, 0);
    }
    for (i = r->y0 + 1; i < r->y1; i++) {
        envlt__moments left = envlt__area_moments(g, table, r, r->x0, r->y0, r->x1, i);
        envlt__try_cut(r, &left, whole, least, 0, i);
    }
    r->rank = r->cut_x | r->cut_y ? r->gain * r->sum.w * r->sum.w * r->sum.w : -1.0;
}

/* Cuts region a where it is best cut, and makes b of the far half. */
static void envlt__cut_region(envlt__region *a, envlt__region *b)
{
    *b = *a;
    if (a->cut_x) a->x1 = b->x0 = a->cut_x;
    else a->y1 = b->y0 = a->cut_y;
}

/* Cuts n regions into k, as far as cuts are found, and returns how many there are then. */
static uint32_t envlt__run_variance(const envlt__grid *g, const envlt__moments *table, envlt__region *r,
                                    uint32_t n, uint32_t k)
{
    uint32_t i;
    for (i = 0; i < n; i++) envlt__best_cut(g, table, &r[i]);
    while (n < k) {
        uint32_t best = 0;
        for (i = 1; i < n; i++)
            if (r[i].rank > r[best].rank) best = i;
        if (!(r[best].cut_x | r[best].cut_y)) break;
        envlt__cut_region(&r[best], &r[n]);
        envlt__best_cut(g, table, &r[best]);
        envlt__best_cut(g, table, &r[n++]);
    }
    return n;
}

/* Returns the column in which the energy from the region's left edge passes the target, and writes to *nearer
   which edge of that column comes closer to the target. Without along_x it does so for rows from the top. */
static uint32_t envlt__locate_energy(const envlt__grid *g, const double *table, const envlt__region *r,
                                     int along_x, double target, uint32_t *nearer)
{
    uint32_t lo = along_x ? r->x0 : r->y0, hi = along_x ? r->x1 : r->y1;
    double a = 0.0, b = r->sum.w;
    while (hi - lo > 1) {
        uint32_t mid = lo + (hi - lo) / 2;
        double w = along_x ? envlt__area_energy(g, table, r, r->x0, r->y0, mid, r->y1)
                           : envlt__area_energy(g, table, r, r->x0, r->y0, r->x1, mid);
        if (w <= target) {
            lo = mid;
            a = w;
        } else {
            hi = mid;
            b = w;
        }
    }
    *nearer = target - a <= b - target ? lo : hi;
    return lo;
}

/* Returns the line inside the region at which the energy comes nearest to the target. The region must have
   two columns (with along_x) or two rows at least. */
static uint32_t envlt__find_cut(const envlt__grid *g, const double *table, const envlt__region *r,
                                int along_x, double target)
{
    uint32_t begin = along_x ? r->x0 : r->y0, end = along_x ? r->x1 : r->y1, line;
    envlt__locate_energy(g, table, r, along_x, target, &line);
    return line <= begin ? begin + 1 : line >= end ? end - 1 : line;
}

/* Shares the lights out among the faces by energy. A face with any energy gets at least one light. */
static void envlt__share_faces(const envlt__grid *g, const double *table, envlt__region *r, uint32_t k)
{
    uint32_t f, given = 0, lit = 0;
    double before = 0.0, total = 0.0;
    for (f = 0; f < g->faces; f++) {
        r[f].sum.w = envlt__area_energy(g, table, &r[f], 0, 0, g->width, g->height);
        lit += r[f].sum.w > 0.0;
        total += r[f].sum.w;
    }
    for (f = 0; f < g->faces; f++) {
        uint32_t until;
        before += r[f].sum.w;
        /* before is summed as total was, so that after the last lit face this is exactly k - lit. */
        until = (uint32_t)((double)(k - lit) * (total > 0.0 ? before / total : 0.0) + 0.5);
        r[f].lights = r[f].sum.w > 0.0 ? until - given + 1 : 0;
        given = r[f].sum.w > 0.0 ? until : given;
    }
}

/* Cuts regions by Debevec, "A median cut algorithm for light probe sampling", 2005, for any k: a region that
   is to become n lights is cut across its longer side into shares of n / 2 and n - n / 2. Returns how many
   regions there are then. */
static uint32_t envlt__run_median(const envlt__grid *g, const double *table, envlt__region *r, uint32_t n,
                                  uint32_t k)
{
    uint32_t i;
    envlt__share_faces(g, table, r, k);
    for (i = 0; i < n;) {
        uint32_t w = r[i].x1 - r[i].x0, h = r[i].y1 - r[i].y0, half = r[i].lights / 2, m;
        double s = 1.0, c, wide, high = h;
        int along_x;
        if (r[i].lights < 2 || (w < 2 && h < 2)) {
            i++;
            continue;
        }
        if (g->faces == 1) envlt__sincos64(ENVLT__PI * (r[i].y0 + 0.5 * h) / g->height, &s, &c);
        wide = g->faces == 1 ? 2.0 * s * w * g->height / g->width : (double)w;
        along_x = h < 2 || (w >= 2 && wide >= high);
        m = envlt__find_cut(g, table, &r[i], along_x, r[i].sum.w * half / r[i].lights);
        r[i].cut_x = along_x ? m : 0;
        r[i].cut_y = along_x ? 0 : m;
        envlt__cut_region(&r[i], &r[n]);
        r[n].lights = r[i].lights - half;
        r[i].lights = half;
        r[i].sum.w = envlt__area_energy(g, table, &r[i], r[i].x0, r[i].y0, r[i].x1, r[i].y1);
        r[n].sum.w = envlt__area_energy(g, table, &r[n], r[n].x0, r[n].y0, r[n].x1, r[n].y1);
        n++;
    }
    return n;
}

/* Divides a strip of rows into cells of equal energy, and returns how many. chosen receives the texel in the
   middle of each cell's energy. */
static uint32_t envlt__invert_strip(const envlt__grid *g, const double *table, const envlt__region *strip,
                                    uint32_t cells, uint32_t row, envlt__region *r, uint32_t *chosen)
{
    uint32_t j, n = 0, line;
    double part = strip->sum.w / cells;
    if (strip->x1 - strip->x0 < 2) cells = 1;
    for (j = 0; j < cells; j++) {
        uint32_t column = envlt__locate_energy(g, table, strip, 1, part * (j + 0.5), &line);
        r[n] = *strip;
        if (j) r[n].x0 = envlt__find_cut(g, table, strip, 1, part * j);
        if (j + 1 < cells) r[n].x1 = envlt__find_cut(g, table, strip, 1, part * (j + 1.0));
        if (r[n].x0 >= r[n].x1) continue;
        column = column < r[n].x0 ? r[n].x0 : column >= r[n].x1 ? r[n].x1 - 1 : column;
        chosen[n++] = (strip->face * g->height + row) * g->width + column;
    }
    return n;
}

/* Inverts the cumulative distribution at the centres (i + 0.5) / n of a grid: strips of rows of equal energy
   are divided into cells of equal energy. Cells of one column (row) become one. Returns how many remain. */
static uint32_t envlt__run_inversion(const envlt__grid *g, const double *table, envlt__region *r, uint32_t k,
                                     uint32_t *chosen)
{
    envlt__region faces[6], strip;
    uint32_t f, i, n = 0, line;
    memcpy(faces, r, g->faces * sizeof *faces);
    envlt__share_faces(g, table, faces, k);
    for (f = 0; f < g->faces; f++) {
        const envlt__region *all = &faces[f];
        uint32_t lights = all->lights;
        uint32_t strips = (uint32_t)(sqrt((double)lights * (g->faces == 1 ? 0.5 : 1.0)) + 0.5);
        double part;
        strips = strips < 1 ? 1 : strips > g->height ? g->height : strips;
        part = all->sum.w / strips;
        if (!lights) {                      /* the light of a black face is dropped later, and its texels go
                                               to the nearest light */
            chosen[n] = 0;
            r[n++] = *all;
            continue;
        }
        for (i = 0; i < strips; i++) {
            uint32_t cells = (uint32_t)((uint64_t)(i + 1) * lights / strips - (uint64_t)i * lights / strips);
            uint32_t row = envlt__locate_energy(g, table, all, 0, part * (i + 0.5), &line);
            strip = *all;
            if (i) strip.y0 = envlt__find_cut(g, table, all, 0, part * i);
            if (i + 1 < strips) strip.y1 = envlt__find_cut(g, table, all, 0, part * (i + 1.0));
            if (strip.y0 >= strip.y1) continue;
            row = row < strip.y0 ? strip.y0 : row >= strip.y1 ? strip.y1 - 1 : row;
            strip.sum.w = envlt__area_energy(g, table, &strip, 0, strip.y0, strip.x1, strip.y1);
            n += envlt__invert_strip(g, table, &strip, cells, row, r + n, chosen + n);
        }
    }
    return n;
}

/* Labels each texel with its region. chosen receives the texels that ENVLT_METHOD_CDF picks; other methods
   leave it alone. */
static envlt_result envlt__label_regions(const envlt__grid *g, envlt_method method, uint32_t k,
                                         uint32_t *label, uint32_t *chosen, const envlt__allocator *a)
{
    size_t entries = ((size_t)g->width + 1) * ((size_t)g->height + 1) * g->faces;
    int by_variance = method != ENVLT_METHOD_CDF && method != ENVLT_METHOD_MEDIAN_CUT;
    void *table = envlt__alloc_array(a, entries, by_variance ? sizeof(envlt__moments) : sizeof(double));
    envlt__region *r = table ? (envlt__region *)envlt__alloc_array(a, (size_t)k + 6, sizeof *r) : NULL;
    uint32_t i, n, x, y;

    if (!r) {
        envlt__free(a, table);
        return ENVLT_ERR_ALLOC;
    }
    if (by_variance) envlt__fill_table(g, (envlt__moments *)table);
    else envlt__fill_energy(g, (double *)table);
    memset(r, 0, 6 * sizeof *r);
    for (n = 0; n < g->faces; n++) {
        r[n].face = n;
        r[n].x1 = g->width;
        r[n].y1 = g->height;
    }
    if (by_variance) n = envlt__run_variance(g, (const envlt__moments *)table, r, n, k);
    else if (method == ENVLT_METHOD_CDF) n = envlt__run_inversion(g, (const double *)table, r, k, chosen);
    else n = envlt__run_median(g, (const double *)table, r, n, k);
    for (i = 0; i < n; i++)
        for (y = r[i].y0; y < r[i].y1; y++) {
            uint32_t *row = label + ((size_t)r[i].face * g->height + y) * g->width;
            for (x = r[i].x0; x < r[i].x1; x++) row[x] = i;
        }
    envlt__free(a, r);
    envlt__free(a, table);
    return ENVLT_OK;
}

/* ==== src/envlights/lights.h ==== */

/* ---- lights: from strata to lights ---- */

typedef struct envlt__sums {        /* sums over the texels of a stratum; d is a texel's direction */
    double rgb[3];                  /* radiance x solid angle */
    double omega;                   /* solid angle */
    double w;                       /* energy: luminance x solid angle */
    double m[3];                    /* w d */
    double s[6];                    /* w d d^T: xx xy xz yy yz zz */
    double o[3];                    /* omega d of dark texels, which say where a stratum without energy lies
                                       */
    double texels;                  /* how many there are */
} envlt__sums;

/* Counts the bytes that an allocator has given out, for envlt_stats.peak_bytes. The size of a block stands in
   front of the block. */
typedef struct envlt__meter { envlt__allocator inner; size_t now, peak; } envlt__meter;

struct envlt_lights {
    envlt__allocator allocator;     /* the caller's, called through the meter */
    envlt__meter     meter;
    envlt_desc   desc;
    envlt_map    map;               /* the projection and sizes of the map; rgb is NULL */
    uint32_t     roll;              /* the column of the map at which the grid begins */
    uint32_t     count;             /* lights */
    uint32_t     next_id;           /* the id of the next new light */
    int          has_sun;           /* not 0: light 0 is the sun */
    size_t       lit;               /* how many texels were lit, the sun counted as one, if they were too few
                                       for all lights; else 0 */
    double       slack;             /* how uneven the strata were when built, which envlt_follow tolerates
                                       twice; 0 = not measured yet */
    envlt_light *list;
    envlt__sums *sums;              /* of each light's stratum */
    size_t       texels;
    uint32_t    *strata;            /* the light of each texel of the map */
    uint32_t    *order;             /* the texels of stratum i are order[start[i] .. start[i + 1]) */
    uint32_t    *start;
    double      *cdf;               /* running sums of w; those of stratum i begin at start[i] + i */
};

/* Sums up all texels of the grid by label. While the label stays the same, sums are kept in a local copy,
   which is faster than memory that each texel reads and writes. */
static void envlt__accumulate_sums(const envlt__grid *g, const uint32_t *label, envlt__sums *sums,
                                   uint32_t count)
{
    size_t t;
    float rgb[3];
    envlt__sums s;
    uint32_t column = 0, held = ENVLT_NO_LIGHT;
    memset(sums, 0, count * sizeof *sums);
    memset(&s, 0, sizeof s);
    for (t = 0; t < g->count; t++, column = column + 1 < g->width ? column + 1 : 0) {
        double omega = (double)g->omega[t];
        double w = envlt__texel_weight(g, t);
        double x, y, z;
        if (!(omega > 0.0) || label[t] >= count) continue;
        if (label[t] != held) {
            if (held != ENVLT_NO_LIGHT) sums[held] = s;
            held = label[t];
            s = sums[held];
        }
        x = (double)g->dx[t];
        y = (double)g->dy[t];
        z = (double)g->dz[t];
        s.omega += omega;
        s.texels += 1.0;
        if (!(w > 0.0)) {
            s.o[0] += omega * x;
            s.o[1] += omega * y;
            s.o[2] += omega * z;
            continue;
        }
        envlt__fetch_texel(&g->map, envlt__map_texel(g, t - column, column), rgb);
        s.rgb[0] += omega * (double)rgb[0];
        s.rgb[1] += omega * (double)rgb[1];
        s.rgb[2] += omega * (double)rgb[2];
        s.w += w;
        s.m[0] += w * x;
        s.m[1] += w * y;
        s.m[2] += w * z;
        s.s[0] += w * x * x;
        s.s[1] += w * x * y;
        s.s[2] += w * x * z;
        s.s[3] += w * y * y;
        s.s[4] += w * y * z;
        s.s[5] += w * z * z;
    }
    if (held != ENVLT_NO_LIGHT) sums[held] = s;
}

/* Returns a direction of the grid, whose azimuths begin at the roll, as a direction of the map. */
static envlt__v3 envlt__unroll_direction(const envlt__grid *g, double x, double y, double z)
{
    double s, c;
    if (g->faces == 6) return envlt__v3_make((float)x, (float)y, (float)z);
    envlt__sincos64(2.0 * ENVLT__PI * ((double)g->roll / g->width - 0.5), &s, &c);
    return envlt__v3_make((float)(x * c - z * s), (float)y, (float)(x * s + z * c));
}

/* Finds the half axes of the ellipse over which the stratum's radiance spreads about its light's direction d:
   the eigenvectors of the 2 x 2 covariance in the tangent plane, as long as twice the standard deviation,
   which is the radius of a uniform disc. The size of a texel itself is added to the covariance. */
static void envlt__find_extent(const envlt__sums *s, envlt__v3 d, envlt__v3 *major, envlt__v3 *minor)
{
    envlt__v3 u, v;
    double a = 0.0, b = 0.0, c = 0.0, texel = s->texels > 0.0 ? s->omega / s->texels / 12.0 : 0.0;
    double half, root, along;
    double x = 1.0;
    double y = 0.0;
    double length;
    float p[3], q[3];
    int i, j;
    envlt__v3_basis(d, &u, &v);
    envlt__v3_store(p, u);
    envlt__v3_store(q, v);
    if (s->w > 0.0) {
        static const int at[3][3] = { { 0, 1, 2 }, { 1, 3, 4 }, { 2, 4, 5 } };
        for (i = 0; i < 3; i++)
            for (j = 0; j < 3; j++) {
                double e = s->s[at[i][j]] / s->w;
                a += (double)p[i] * e * (double)p[j];
                b += (double)p[i] * e * (double)q[j];
                c += (double)q[i] * e * (double)q[j];
            }
    }
    a += texel;
    c += texel;
    half = 0.5 * (a - c);
    root = sqrt(half * half + b * b);
    along = 0.5 * (a + c);
    if (root > 0.0) {
        x = half >= 0.0 ? half + root : b;
        y = half >= 0.0 ? b : root - half;
        length = sqrt(x * x + y * y);
        x /= length;
        y /= length;
    }
    *major = envlt__v3_add(envlt__v3_scale(u, (float)x), envlt__v3_scale(v, (float)y));
    *minor = envlt__v3_cross(d, *major);
    *major = envlt__v3_scale(*major, (float)(2.0 * sqrt(along + root)));
    *minor = envlt__v3_scale(*minor, (float)(2.0 * sqrt(along > root ? along - root : 0.0)));
}

/* Makes a light of a stratum's sums. Its direction is that of the texel `chosen`, or the stratum's mean
   direction if chosen is ENVLT_NO_LIGHT. */
static void envlt__make_light(const envlt__grid *g, const envlt__sums *s, uint32_t chosen, envlt_light *light)
{
    double x = s->m[0];
    double y = s->m[1];
    double z = s->m[2];
    double least = 1e-9 * s->w;
    double length;
    envlt__v3 d, major, minor;
    int c;
    if (chosen != ENVLT_NO_LIGHT) {
        x = (double)g->dx[chosen];
        y = (double)g->dy[chosen];
        z = (double)g->dz[chosen];
        least = 0.0;                                    /* a texel's direction is unit, whatever its energy */
    }
    length = sqrt(x * x + y * y + z * z);
    if (!(length > least)) {                            /* light comes evenly from all round: any direction
                                                           will do */
        x = z = 0.0;
        y = length = 1.0;
    }
    d = envlt__v3_make((float)(x / length), (float)(y / length), (float)(z / length));
    envlt__find_extent(s, d, &major, &minor);
    envlt__v3_store(light->direction,
                    envlt__v3_normalize(envlt__unroll_direction(g, (double)d.x, (double)d.y, (double)d.z)));
    envlt__v3_store(light->axis_u,
                    envlt__unroll_direction(g, (double)major.x, (double)major.y, (double)major.z));
    envlt__v3_store(light->axis_v,
                    envlt__unroll_direction(g, (double)minor.x, (double)minor.y, (double)minor.z));
    for (c = 0; c < 3; c++) light->irradiance[c] = (float)s->rgb[c];
    light->solid_angle = (float)s->omega;
}

/* Gives the texels of strata without energy to the light whose mean direction is nearest, numbers the other
   strata without gaps, and returns how many are left. remap is scratch of count entries. */
static uint32_t envlt__drop_dark(const envlt__grid *g, uint32_t *label, envlt__sums *sums, uint32_t *chosen,
                                 uint32_t *remap, uint32_t count)
{
    uint32_t i, j, n = 0;
    size_t t;
    for (i = 0; i < count; i++)
        if (sums[i].w > 0.0) remap[i] = n++;
    if (n == count || n == 0) return n;
    for (i = 0; i < count; i++) {
        double best = 0.0;
        uint32_t nearest = ENVLT_NO_LIGHT;
        for (j = 0; j < count && !(sums[i].w > 0.0); j++) {
            const double *m = sums[j].m, *o = sums[i].o;
            double c = m[0] * o[0] + m[1] * o[1] + m[2] * o[2];
            if (!(sums[j].w > 0.0)) continue;
            c /= sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]) + 1e-300;
            if (nearest != ENVLT_NO_LIGHT && c <= best) continue;
            best = c;
            nearest = remap[j];
        }
        if (!(sums[i].w > 0.0)) remap[i] = nearest;
    }
    for (t = 0; t < g->count; t++)
        if (label[t] < count) label[t] = remap[label[t]];
    for (i = n = 0; i < count; i++)
        if (sums[i].w > 0.0) chosen[n++] = chosen[i];
    envlt__accumulate_sums(g, label, sums, n);
    return n;
}

/* ==== src/envlights/strata.h ==== */

/* ---- sun: the spot that gets a light of its own ---- */

/* Finds the sun: the connected spot about the brightest texel in which luminance is above a tenth of the
   greatest. It must be smaller than 0.03 sr (11 degrees across) and have a light's share of the energy.
   Writes its texels to the queue, which has room for all texels, and returns how many they are; 0 if there is
   no sun. */
static uint32_t envlt__find_sun(const envlt__grid *g, uint32_t k, uint32_t *queue, uint8_t *seen)
{
    uint32_t head = 0, tail = 0, next[4], i;
    size_t t, top = 0;
    double energy = 0.0, omega = 0.0;
    for (t = 1; t < g->count; t++)
        if (g->lum[t] > g->lum[top]) top = t;
    if (!(g->lum[top] > 0.0f)) return 0;
    memset(seen, 0, g->count);
    queue[tail++] = (uint32_t)top;
    seen[top] = 1;
    while (head < tail && omega < 0.03) {
        t = queue[head++];
        energy += envlt__texel_weight(g, t);
        omega += (double)g->omega[t];
        envlt__neighbours(g, (uint32_t)t, next);
        for (i = 0; i < 4; i++)
            if (!seen[next[i]] && g->lum[next[i]] > 0.1f * g->lum[top]) {
                seen[next[i]] = 1;
                queue[tail++] = next[i];
            }
    }
    return head == tail && omega < 0.03 && energy * k >= g->total && k > 1 ? tail : 0;
}

/* Returns how many texels are lit. If label is not NULL, texels with label 0, those of the sun, do not count.
   */
static size_t envlt__count_lit(const envlt__grid *g, const uint32_t *label)
{
    size_t t, lit = 0;
    for (t = 0; t < g->count; t++) lit += g->lum[t] > 0.0f && !(label && label[t] == 0);
    return lit;
}

/* ---- strata: what is kept of a map ---- */

/* Writes which light each texel of the map belongs to, and lists the texels of each stratum. */
static void envlt__sort_strata(envlt_lights *l, const envlt__grid *g, const uint32_t *label)
{
    uint32_t i, x = 0;
    size_t t;
    for (i = 0; i <= l->count; i++) l->start[i] = 0;
    for (t = 0; t < g->count; t++, x = x + 1 < g->width ? x + 1 : 0) {
        uint32_t s = g->omega[t] > 0.0f && l->count ? label[t] : ENVLT_NO_LIGHT;
        l->strata[envlt__map_texel(g, t - x, x)] = s;
        if (s != ENVLT_NO_LIGHT) l->start[s]++;
    }
    for (i = 0, t = 0; i <= l->count; i++) {
        size_t n = l->start[i];
        l->start[i] = (uint32_t)t;
        t += i < l->count ? n : 0;
    }
    for (t = 0; t < g->count; t++)          /* texels of a stratum stand in the grid's order */
        if (g->omega[t] > 0.0f && l->count) l->order[l->start[label[t]]++] = (uint32_t)t;
    for (i = l->count; i > 0; i--) l->start[i] = l->start[i - 1];
    l->start[0] = 0;
}

/* Fills in the running sums by which envlt_jitter chooses texels. The strata must not change afterwards. */
static void envlt__fill_cdf(envlt_lights *l, const envlt__grid *g)
{
    uint32_t i, j;
    for (i = 0; i < l->count; i++) {
        double sum = 0.0, *out = l->cdf + l->start[i] + i;
        for (j = l->start[i]; j < l->start[i + 1]; j++) {
            *out++ = sum;
            sum += envlt__texel_weight(g, l->order[j]);
        }
        *out = sum;
    }
}

/* Makes the lights of their sums, each towards its chosen texel or, without any, its stratum's mean. */
static void envlt__fill_lights(envlt_lights *l, const envlt__grid *g, const uint32_t *chosen)
{
    uint32_t i;
    for (i = 0; i < l->count; i++) {
        /* The light of a stratum that a video has made black keeps its direction. */
        if (l->sums[i].w > 0.0) {
            envlt__make_light(g, &l->sums[i], chosen ? chosen[i] : ENVLT_NO_LIGHT, &l->list[i]);
        } else {
            l->list[i].irradiance[0] = l->list[i].irradiance[1] = l->list[i].irradiance[2] = 0.0f;
            l->list[i].solid_angle = (float)l->sums[i].omega;
        }
        l->list[i].flags = l->has_sun && i == 0 ? ENVLT_LIGHT_SUN : 0;
    }
}

/* Makes room for k lights, more or less than there are, and keeps those that there are. Returns 0 if there is
   no memory. */
static int envlt__reserve_lights(envlt_lights *l, uint32_t k)
{
    const envlt__allocator *a = &l->allocator;
    envlt_light *list = (envlt_light *)envlt__alloc_array(a, (size_t)k + 1, sizeof *list);
    envlt__sums *sums = (envlt__sums *)envlt__alloc_array(a, (size_t)k + 1, sizeof *sums);
    uint32_t *start = (uint32_t *)envlt__alloc_array(a, (size_t)k + 2, sizeof *start);
    double *cdf = (double *)envlt__alloc_array(a, l->texels + k + 1, sizeof *cdf);
    if (!list || !sums || !start || !cdf) {
        envlt__free(a, cdf);
        envlt__free(a, start);
        envlt__free(a, sums);
        envlt__free(a, list);
        return 0;
    }
    memset(list, 0, ((size_t)k + 1) * sizeof *list);
    if (l->list) {
        memcpy(list, l->list, l->count * sizeof *list);
        memcpy(sums, l->sums, l->count * sizeof *sums);
        memcpy(start, l->start, ((size_t)l->count + 1) * sizeof *start);
    }
    envlt__free(a, l->cdf);
    envlt__free(a, l->start);
    envlt__free(a, l->sums);
    envlt__free(a, l->list);
    l->list = list;
    l->sums = sums;
    l->start = start;
    l->cdf = cdf;
    return 1;
}

/* Logs that a side of the map is not that of the map before, which is wanted. */
static envlt_result envlt__refuse_other(const envlt__logger *logger, const char *field, uint32_t value,
                                        uint32_t wanted)
{
    envlt__message text;
    text.used = 0;
    envlt__message_count(&text, wanted);
    envlt__message_text(&text, ", as that of the map before");
    return envlt__refuse(logger, field, value, text.text, ENVLT_ERR_MISMATCH);
}

/* Checks whether a map has the size and projection of the one that the lights were made of. */
static envlt_result envlt__check_same(const envlt_lights *l, const envlt_map *map,
                                      const envlt__logger *logger)
{
    size_t texels;
    envlt_result result;
    if (!map) return envlt__refuse_text(logger, "map", "is NULL", ENVLT_ERR_ARGUMENT);
    result = envlt__check_map(map, &texels, logger);
    if (result != ENVLT_OK) return result;
    if (map->width != l->map.width)
        return envlt__refuse_other(logger, "map.width", map->width, l->map.width);
    if (map->height != l->map.height)
        return envlt__refuse_other(logger, "map.height", map->height, l->map.height);
    if (texels != l->texels)
        return envlt__refuse_text(logger, "map.projection", "is not that of the map before",
                                  ENVLT_ERR_MISMATCH);
    return ENVLT_OK;
}

/* ==== src/envlights/build.h ==== */

/* ---- build: a map becomes strata, and strata lights ---- */

/* Labels texels by the method. A cube with fewer lights than faces goes to the structured method, since the
   others give each face a light. */
static envlt_result envlt__label_texels(const envlt__grid *g, envlt_method method, uint32_t k,
                                        uint32_t *label, uint32_t *chosen, const envlt__allocator *a)
{
    if (method == ENVLT_METHOD_STRUCTURED || (g->faces == 6 && k < 6))
        return envlt__label_structured(g, k, label, a);
    return envlt__label_regions(g, method, k, label, chosen, a);
}

/* Gives label 0 to the sun, if desc.split_sun is set and there is a sun, and labels the other texels by the
   method. Writes how many labels there may be. */
static envlt_result envlt__label_with_sun(envlt_lights *l, const envlt__grid *g, uint32_t *label,
                                          uint32_t *chosen, uint32_t *labels)
{
    const envlt__allocator *a = &l->allocator;
    uint32_t k = l->desc.light_count, size = 0, i;
    uint32_t *queue = NULL;
    uint8_t *seen = NULL;
    float *kept = NULL;
    envlt_result result;
    size_t t;
    if (l->desc.split_sun) {
        queue = (uint32_t *)envlt__alloc_array(a, g->count, sizeof *queue);
        seen = queue ? (uint8_t *)envlt__alloc(a, g->count) : NULL;
        size = seen ? envlt__find_sun(g, k, queue, seen) : 0;
        kept = size ? (float *)envlt__alloc_array(a, size, sizeof *kept) : NULL;
    }
    if (l->desc.split_sun && (!seen || (size && !kept))) {
        result = ENVLT_ERR_ALLOC;
    } else {
        envlt__grid rest = *g;
        for (i = 0; i < size; i++) {
            kept[i] = g->lum[queue[i]];
            g->lum[queue[i]] = 0.0f;
        }
        /* The rest is summed anew. Beside a sun with 1e16 times the energy of the sky, the total less the sun
           would be nothing but rounding, and perhaps negative. */
        if (size) rest.total = envlt__sum_weights(g);
        result = envlt__label_texels(&rest, l->desc.method, size ? k - 1 : k, label, chosen + (size != 0), a);
        for (t = 0; size && t < g->count; t++) label[t] += label[t] != ENVLT_NO_LIGHT;
        for (i = 0; i < size; i++) {
            g->lum[queue[i]] = kept[i];
            label[queue[i]] = 0;
        }
        if (size) chosen[0] = ENVLT_NO_LIGHT;
        l->has_sun = size != 0;
        *labels = k + 6;
    }
    envlt__free(a, kept);
    envlt__free(a, seen);
    envlt__free(a, queue);
    return result;
}

/* Makes strata and lights of the grid. The labels are kept in the memory of the running sums, which are
   written last: to ask for fresh memory would cost as much time as to fill it with labels. */
static envlt_result envlt__build_lights(envlt_lights *l, const envlt__grid *g)
{
    const envlt__allocator *a = &l->allocator;
    uint32_t k = l->desc.light_count, labels = 0, i, *label = (uint32_t *)(void *)l->cdf;
    uint32_t *chosen = (uint32_t *)envlt__alloc_array(a, (size_t)k + 7, 2 * sizeof *chosen);
    envlt__sums *sums = chosen ? (envlt__sums *)envlt__alloc_array(a, (size_t)k + 7, sizeof *sums) : NULL;
    envlt_result result = ENVLT_ERR_ALLOC;
    size_t t;
    if (sums) {
        for (i = 0; i < k + 7; i++) chosen[i] = ENVLT_NO_LIGHT;
        for (t = 0; t < g->count; t++) label[t] = ENVLT_NO_LIGHT;
        result = g->total > 0.0 ? envlt__label_with_sun(l, g, label, chosen, &labels) : ENVLT_OK;
    }
    if (result == ENVLT_OK) {
        envlt__accumulate_sums(g, label, sums, labels);
        l->count = envlt__drop_dark(g, label, sums, chosen, chosen + k + 7, labels);
        if (l->desc.method != ENVLT_METHOD_CDF)
            for (i = 0; i < l->count; i++) chosen[i] = ENVLT_NO_LIGHT;
        memcpy(l->sums, sums, l->count * sizeof *sums);
        l->lit = l->count < k ? envlt__count_lit(g, l->has_sun ? label : NULL) + (l->has_sun ? 1 : 0) : 0;
        if (l->lit > k) l->lit = 0;         /* the method's rounding made lights fewer, not the map */
        envlt__sort_strata(l, g, label);
        envlt__fill_lights(l, g, chosen);
        envlt__fill_cdf(l, g);
        for (i = 0; i < l->count; i++) l->list[i].id = l->next_id++;
    }
    envlt__free(a, sums);
    envlt__free(a, chosen);
    return result;
}

/* Allocates through a meter, whose block begins with the size that was asked for. */
static void *envlt__meter_alloc(size_t size, void *user)
{
    envlt__meter *m = (envlt__meter *)user;
    char *block = size <= SIZE_MAX - 16 ? (char *)envlt__alloc(&m->inner, size + 16) : NULL;
    if (!block) return NULL;
    memcpy(block, &size, sizeof size);
    m->now += size + 16;
    if (m->now > m->peak) m->peak = m->now;
    return block + 16;
}

static void envlt__meter_free(void *memory, void *user)
{
    envlt__meter *m = (envlt__meter *)user;
    char *block = (char *)memory - 16;
    size_t size;
    memcpy(&size, block, sizeof size);
    m->now -= size + 16;
    envlt__free(&m->inner, block);
}

static void envlt__fill_stats(const envlt_lights *l, const envlt__grid *g, envlt_stats *stats)
{
    uint32_t i;
    int c;
    memset(stats, 0, sizeof *stats);
    stats->lights = l->count;
    stats->bad_texels = g->bad;
    stats->peak_bytes = l->meter.peak;
    for (i = 0; i < l->count; i++)
        for (c = 0; c < 3; c++) stats->energy[c] += l->sums[i].rgb[c];
}

static envlt_result envlt__check_desc(const envlt_desc *d, const envlt__logger *logger)
{
    if (d->light_count > ENVLT_MAX_LIGHTS)
        return envlt__refuse(logger, "desc.light_count", d->light_count, "0 (= 128) or 1..8192",
                             ENVLT_ERR_DESC);
    if ((unsigned)d->method >= ENVLT_METHOD_COUNT)
        return envlt__refuse(logger, "desc.method", d->method, "one of envlt_method", ENVLT_ERR_DESC);
    if (!envlt__allocator_valid(d->system.allocator.alloc_fn, d->system.allocator.free_fn))
        return envlt__refuse_text(logger, "desc.system.allocator", "has one of its two functions",
                                  ENVLT_ERR_DESC);
    return ENVLT_OK;
}

/* Returns an object without lights, whose memory goes through its meter, or NULL if there is no memory. */
static envlt_lights *envlt__make_empty(const envlt_desc *d, const envlt_map *map, size_t texels)
{
    const envlt_allocator *a = &d->system.allocator;
    envlt__allocator inner = envlt__allocator_make(a->alloc_fn, a->free_fn, a->user);
    envlt_lights *l = (envlt_lights *)envlt__alloc(&inner, sizeof *l);
    if (!l) return NULL;
    memset(l, 0, sizeof *l);
    l->meter.inner = inner;
    l->meter.now = l->meter.peak = sizeof *l;
    l->allocator = envlt__allocator_make(envlt__meter_alloc, envlt__meter_free, &l->meter);
    l->desc = *d;
    l->map = *map;
    l->map.rgb = NULL;
    l->texels = texels;
    return l;
}

/* Makes lights of a map; desc and map have been checked, and desc has its defaults. Fails with
   ENVLT_ERR_ALLOC alone, which the caller logs. */
static envlt_result envlt__make_lights(const envlt_desc *d, const envlt_map *map, size_t texels,
                                       envlt_lights **out, envlt_stats *stats)
{
    envlt__grid grid;
    envlt_result result;
    envlt_lights *l = envlt__make_empty(d, map, texels);
    if (!l) return ENVLT_ERR_ALLOC;
    memset(&grid, 0, sizeof grid);
    result = envlt__make_grid(&grid, map, d->hemisphere, ENVLT_NO_LIGHT, &l->allocator);
    l->roll = grid.roll;
    l->strata = (uint32_t *)envlt__alloc_array(&l->allocator, texels, sizeof *l->strata);
    l->order = (uint32_t *)envlt__alloc_array(&l->allocator, texels, sizeof *l->order);
    if (result == ENVLT_OK && (!l->strata || !l->order || !envlt__reserve_lights(l, d->light_count + 6)))
        result = ENVLT_ERR_ALLOC;
    if (result == ENVLT_OK) result = envlt__build_lights(l, &grid);
    envlt__free(&l->allocator, grid.memory);
    if (result != ENVLT_OK) {
        envlt_free(l);
        return result;
    }
    if (stats) envlt__fill_stats(l, &grid, stats);
    *out = l;
    return ENVLT_OK;
}

ENVLT_DEF envlt_result envlt_create(const envlt_desc *desc, const envlt_map *map, envlt_lights **out,
                                    envlt_stats *stats)
{
    envlt__logger logger;
    envlt_desc d;
    envlt_result result;
    size_t texels = 0;

    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    logger = envlt__make_logger(&d.system, "envlt_create");
    if (!map) return envlt__refuse_text(&logger, "map", "is NULL", ENVLT_ERR_ARGUMENT);
    if (!out) return envlt__refuse_text(&logger, "out", "is NULL", ENVLT_ERR_ARGUMENT);
    result = envlt__check_desc(&d, &logger);
    if (result == ENVLT_OK) result = envlt__check_map(map, &texels, &logger);
    if (result != ENVLT_OK) return result;
    if (!d.light_count) d.light_count = 128;
    if (d.method == ENVLT_METHOD_DEFAULT) d.method = ENVLT_METHOD_VARIANCE;
    return envlt__end_call(&logger, envlt__make_lights(&d, map, texels, out, stats));
}

ENVLT_DEF void envlt_free(envlt_lights *l)
{
    envlt__allocator inner;
    if (!l) return;
    inner = l->meter.inner;
    envlt__free(&l->allocator, l->cdf);
    envlt__free(&l->allocator, l->start);
    envlt__free(&l->allocator, l->sums);
    envlt__free(&l->allocator, l->list);
    envlt__free(&l->allocator, l->order);
    envlt__free(&l->allocator, l->strata);
    envlt__free(&inner, l);
}

ENVLT_DEF const envlt_light *envlt_get_lights(const envlt_lights *lights, uint32_t *count)
{
    if (count) *count = lights ? lights->count : 0;
    return lights ? lights->list : NULL;
}

ENVLT_DEF const uint32_t *envlt_strata(const envlt_lights *lights, size_t *count)
{
    if (count) *count = lights ? lights->texels : 0;
    return lights ? lights->strata : NULL;
}

/* ---- jitter ---- */

ENVLT_DEF envlt_result envlt_jitter(const envlt_lights *l, uint32_t frame, uint32_t seed, envlt_light *out)
{
    uint32_t i;
    envlt__logger logger;
    if (!l) return ENVLT_ERR_ARGUMENT;
    logger = envlt__make_logger(&l->desc.system, "envlt_jitter");
    if (!out && l->count) return envlt__refuse_text(&logger, "out", "is NULL", ENVLT_ERR_ARGUMENT);
    for (i = 0; i < l->count; i++) {
        uint32_t hash = envlt__hash_combine(seed, l->list[i].id), t, row, column;
        uint32_t first = l->start[i], a, b;
        envlt__cdf cdf;
        envlt__cdf_sample s;
        double d[3], length;
        out[i] = l->list[i];
        if (first == l->start[i + 1]) continue;         /* the sun has taken all texels of this stratum */
        /* Points of the R2 sequence, shifted by a hash of the light. The first coordinate chooses the texel,
           and what is left of it says how far across the texel; the second says how far down. */
        a = 0x80000000u + frame * 3242174889u + hash;
        b = 0x80000000u + frame * 2447445413u + envlt__hash32(hash);
        cdf.sums = l->cdf + first + i;
        cdf.count = l->start[i + 1] - first;
        s = envlt__cdf_sample_at(&cdf, envlt__to_unit(a));
        t = l->order[first + s.index];
        row = t / l->map.width;
        column = (uint32_t)(((uint64_t)t % l->map.width + l->roll) % l->map.width);
        envlt__direction(&l->map, row / l->map.height, (double)column + (double)s.fraction,
                         (double)(row % l->map.height) + (double)envlt__to_unit(b), d);
        length = 1.0 / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        for (row = 0; row < 3; row++) out[i].direction[row] = (float)(d[row] * length);
    }
    return ENVLT_OK;
}

/* ==== src/envlights/follow.h ==== */

/* ---- follow: the next map, or another k, with strata that stay ---- */

typedef struct envlt__follow {
    envlt_lights      *l;
    const envlt__grid *g;
    uint32_t *label;                /* the stratum of each texel of the grid */
    uint32_t *partner;              /* the stratum that each stratum would merge with */
    double   *cost, *gain;          /* the importance that merging a stratum adds, and that splitting it takes
                                       away */
    uint8_t  *touched;              /* not 0: this stratum was changed in this round */
    uint32_t *queue;                /* queue and seen are scratch of the search for the sun; NULL without
                                       split_sun */
    uint8_t  *seen;
    envlt_light *before;            /* the lights as they were */
    uint32_t  changed;              /* lights with a new id */
} envlt__follow;

/* Returns the greatest eigenvalue of a stratum's scatter and writes its eigenvector, found by multiplying a
   vector with the matrix 24 times. */
static double envlt__main_axis(const envlt__sums *s, envlt__v3 *axis)
{
    static const int at[3][3] = { { 0, 1, 2 }, { 1, 3, 4 }, { 2, 4, 5 } };
    double c[3][3], v[3] = { 1.0, 0.9, 0.8 }, length = 0.0;
    int i, j, step;
    for (i = 0; i < 3; i++)
        for (j = 0; j < 3; j++) c[i][j] = s->s[at[i][j]] - s->m[i] * s->m[j] / s->w;
    for (step = 0; step < 24; step++) {
        double u[3];
        for (i = 0; i < 3; i++) u[i] = c[i][0] * v[0] + c[i][1] * v[1] + c[i][2] * v[2];
        length = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        if (!(length > 0.0)) break;
        for (i = 0; i < 3; i++) v[i] = u[i] / length;
    }
    *axis = envlt__v3_make((float)v[0], (float)v[1], (float)v[2]);
    return length;
}

/* A plane that cuts a stratum in two: through the stratum's mean, across its main axis. */
typedef struct envlt__plane { envlt__v3 axis; double mean; } envlt__plane;

static envlt__plane envlt__plane_across(const envlt__sums *s)
{
    envlt__plane p;
    envlt__main_axis(s, &p.axis);
    p.mean = (s->m[0] * (double)p.axis.x + s->m[1] * (double)p.axis.y + s->m[2] * (double)p.axis.z) / s->w;
    return p;
}

/* Returns whether texel t lies on the far side of the plane. */
static int envlt__is_beyond(const envlt__grid *g, const envlt__plane *p, uint32_t t)
{
    return (double)(g->dx[t] * p->axis.x) + (double)(g->dy[t] * p->axis.y) +
           (double)(g->dz[t] * p->axis.z) > p->mean;
}

/* Returns whether both sides of a stratum's cut have energy. The scatter does not tell: by rounding, even a
   single lit texel may have some. */
static int envlt__is_divisible(const envlt__follow *f, uint32_t which)
{
    envlt__plane p = envlt__plane_across(&f->l->sums[which]);
    uint32_t j, sides = 0;
    for (j = f->l->start[which]; j < f->l->start[which + 1] && sides != 3; j++)
        if (f->g->lum[f->l->order[j]] > 0.0f) sides |= envlt__is_beyond(f->g, &p, f->l->order[j]) ? 2u : 1u;
    return sides == 3;
}

/* Returns energy times the fourth root of the scatter per energy, the importance that envlt__best_cut ranks
   by. */
static double envlt__stratum_rank(double w, double scatter) { return sqrt(sqrt(w * w * w * scatter)); }

/* Finds for each stratum the importance that cutting it takes away, and the importance that merging it with
   its best partner adds, by Ward's criterion. The sun is neither cut nor merged. */
static void envlt__rate_strata(envlt__follow *f)
{
    const envlt_lights *l = f->l;
    uint32_t i, j, first = l->has_sun ? 1 : 0;
    envlt__v3 axis;
    for (i = 0; i < l->count; i++) {
        const envlt__sums *a = &l->sums[i];
        f->touched[i] = i < first;
        f->cost[i] = 1e300;
        f->partner[i] = i;
        /* Cutting an even spread in two leaves a quarter of the scatter along the axis. */
        f->gain[i] = a->texels > 1.5 && a->w > 0.0 && i >= first && envlt__is_divisible(f, i)
                   ? 0.75 * envlt__main_axis(a, &axis) : 0.0;
        f->gain[i] = envlt__stratum_rank(a->w, f->gain[i]);
        for (j = first; j < l->count && i >= first; j++) {
            const envlt__sums *b = &l->sums[j];
            double dx, dy, dz, ward;
            if (j == i) continue;
            if (!(a->w > 0.0) || !(b->w > 0.0)) {
                ward = 0.0;
                dx = a->o[0] / (a->omega + 1e-300) - b->o[0] / (b->omega + 1e-300);
                dy = a->o[1] / (a->omega + 1e-300) - b->o[1] / (b->omega + 1e-300);
                dz = a->o[2] / (a->omega + 1e-300) - b->o[2] / (b->omega + 1e-300);
                ward = 1e-30 * (dx * dx + dy * dy + dz * dz);
            } else {
                dx = a->m[0] / a->w - b->m[0] / b->w;
                dy = a->m[1] / a->w - b->m[1] / b->w;
                dz = a->m[2] / a->w - b->m[2] / b->w;
                ward = envlt__stratum_rank(a->w + b->w,
                                           a->w * b->w / (a->w + b->w) * (dx * dx + dy * dy + dz * dz));
            }
            if (ward < f->cost[i]) {
                f->cost[i] = ward;
                f->partner[i] = j;
            }
        }
    }
}

/* Returns the stratum that gains most by a cut, or ENVLT_NO_LIGHT. */
static uint32_t envlt__pick_split(const envlt__follow *f)
{
    uint32_t i, best = ENVLT_NO_LIGHT;
    for (i = 0; i < f->l->count; i++)
        if (!f->touched[i] && f->gain[i] > 0.0 && (best == ENVLT_NO_LIGHT || f->gain[i] > f->gain[best]))
            best = i;
    return best;
}

/* Returns the stratum that loses least by a merge with its partner, or ENVLT_NO_LIGHT. */
static uint32_t envlt__pick_merge(const envlt__follow *f)
{
    uint32_t i, best = ENVLT_NO_LIGHT;
    for (i = 0; i < f->l->count; i++)
        if (!f->touched[i] && f->partner[i] != i && !f->touched[f->partner[i]] &&
            (best == ENVLT_NO_LIGHT || f->cost[i] < f->cost[best])) best = i;
    return best;
}

/* Gives the texels of a stratum that lie beyond its mean along its main axis to stratum `other`. */
static void envlt__split_stratum(envlt__follow *f, uint32_t which, uint32_t other)
{
    envlt__plane p = envlt__plane_across(&f->l->sums[which]);
    uint32_t j;
    for (j = f->l->start[which]; j < f->l->start[which + 1]; j++)
        if (envlt__is_beyond(f->g, &p, f->l->order[j])) f->label[f->l->order[j]] = other;
    f->touched[which] = 1;
}

/* Gives the texels of the fainter stratum of the pair to the brighter one, and returns the number of the
   fainter, which is free then. */
static uint32_t envlt__merge_strata(envlt__follow *f, uint32_t a)
{
    envlt_lights *l = f->l;
    uint32_t b = f->partner[a], keep = l->sums[a].w >= l->sums[b].w ? a : b, gone = keep == a ? b : a, j;
    for (j = l->start[gone]; j < l->start[gone + 1]; j++) f->label[l->order[j]] = keep;
    f->touched[a] = f->touched[b] = 1;
    return gone;
}

/* Moves a light and its texels from one number to another. */
static void envlt__move_label(envlt__follow *f, uint32_t from, uint32_t to)
{
    envlt_lights *l = f->l;
    size_t t;
    for (t = 0; t < f->g->count; t++)
        if (f->label[t] == from) f->label[t] = to;
    l->list[to] = l->list[from];
}

/* Makes sums and lists of texels of the labels. */
static void envlt__sum_strata(envlt__follow *f)
{
    envlt__accumulate_sums(f->g, f->label, f->l->sums, f->l->count);
    envlt__sort_strata(f->l, f->g, f->label);
}

/* Does one round of splits or merges towards k lights. A stratum changes at most once a round, since its
   rating is old then. Returns 0 if nothing is left to do. */
static int envlt__change_count(envlt__follow *f, uint32_t k)
{
    envlt_lights *l = f->l;
    uint32_t which, n = l->count, gone_count = 0, i;
    if (n == k) return 0;
    envlt__rate_strata(f);
    if (n < k) {
        while (n < k && (which = envlt__pick_split(f)) != ENVLT_NO_LIGHT) {
            envlt__split_stratum(f, which, n);
            l->list[n++].id = l->next_id++;
            f->changed++;
        }
        if (n == l->count) return 0;
        l->count = n;
    } else {
        while (n - gone_count > k && (which = envlt__pick_merge(f)) != ENVLT_NO_LIGHT) {
            l->sums[envlt__merge_strata(f, which)].texels = -1.0;
            gone_count++;
        }
        if (!gone_count) return 0;
        for (i = 0; i < n; i++) {           /* the last light takes the empty place */
            while (n > i && l->sums[n - 1].texels < 0.0) n--;
            if (i >= n || !(l->sums[i].texels < 0.0)) continue;
            envlt__move_label(f, n - 1, i);
            n--;
        }
        l->count = n;
    }
    envlt__sum_strata(f);
    return 1;
}

/* Splits a stratum and merges a pair, as long as the split gains more than `ratio` times what the merge
   costs, for at most an eighth of the lights. */
static void envlt__rebalance_strata(envlt__follow *f, double ratio)
{
    uint32_t split, merge;
    uint32_t fresh = f->l->count / 8;
    uint32_t done = 0;
    uint32_t i;
    envlt__rate_strata(f);
    /* Strata whose texels the sun has all taken are free for halves of others. */
    for (i = 0; i < f->l->count; i++) {
        if (f->l->start[i] < f->l->start[i + 1]) continue;
        f->touched[i] = 1;
        split = envlt__pick_split(f);
        if (split == ENVLT_NO_LIGHT) break;
        envlt__split_stratum(f, split, i);
        f->l->list[i].id = f->l->next_id++;
        f->changed++;
        done = 1;
    }
    for (; fresh > 0; fresh--) {
        split = envlt__pick_split(f);
        if (split == ENVLT_NO_LIGHT) break;
        f->touched[split] = 1;              /* the stratum to split must not be one of the pair to merge */
        merge = envlt__pick_merge(f);
        if (merge == ENVLT_NO_LIGHT || !(f->gain[split] > ratio * f->cost[merge])) break;
        merge = envlt__merge_strata(f, merge);
        envlt__split_stratum(f, split, merge);
        f->l->list[merge].id = f->l->next_id++;
        f->changed++;
        done = 1;
    }
    if (done) envlt__sum_strata(f);
}

/* Returns the gain of the best split over the cost of the cheapest merge, at least 1. */
static double envlt__measure_unevenness(envlt__follow *f)
{
    uint32_t split, merge;
    envlt__rate_strata(f);
    split = envlt__pick_split(f);
    if (split == ENVLT_NO_LIGHT) return 1.0;
    f->touched[split] = 1;
    merge = envlt__pick_merge(f);
    if (merge == ENVLT_NO_LIGHT || !(f->gain[split] > f->cost[merge])) return 1.0;
    return f->cost[merge] > 1e-6 * f->gain[split] ? f->gain[split] / f->cost[merge] : 1e6;
}

/* Gives each texel of the sun's stratum to the other light that is nearest to the texel. */
static void envlt__leave_sun(envlt__follow *f)
{
    envlt_lights *l = f->l;
    const envlt__grid *g = f->g;
    uint32_t i, j;
    for (j = l->start[0]; j < l->start[1]; j++) {
        uint32_t t = l->order[j], nearest = 1;
        double best = -2.0;
        for (i = 1; i < l->count; i++) {
            const double *m = l->sums[i].w > 0.0 ? l->sums[i].m : l->sums[i].o;
            double c = (m[0] * (double)g->dx[t] + m[1] * (double)g->dy[t] + m[2] * (double)g->dz[t]) /
                       (sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]) + 1e-300);
            if (c > best) {
                best = c;
                nearest = i;
            }
        }
        f->label[t] = nearest;
    }
}

/* Moves the sun's stratum to where the sun is now. While there is no sun, the stratum stays where it was. A
   sun that comes up becomes light 0, and the light that was light 0 becomes the last one. */
static void envlt__follow_sun(envlt__follow *f)
{
    envlt_lights *l = f->l;
    uint32_t k = l->desc.light_count, size = envlt__find_sun(f->g, k, f->queue, f->seen), i;
    if (k < 2) l->has_sun = 0;
    if (!size || (l->has_sun && l->count < 2)) return;
    if (l->has_sun) {
        envlt__leave_sun(f);
    } else {
        size_t t;
        for (t = 0; t < f->g->count; t++)
            if (f->label[t] == 0) f->label[t] = l->count;
        l->list[l->count++] = l->list[0];
        l->list[0].id = l->next_id++;
        l->has_sun = 1;
        f->changed++;
    }
    for (i = 0; i < size; i++) f->label[f->queue[i]] = 0;
}

/* Brings the strata to the new map: labels, the sun, the count, then the balance. */
static void envlt__run_follow(envlt__follow *f, uint32_t k)
{
    envlt_lights *l = f->l;
    uint32_t x = 0;
    size_t t;
    if (!(l->slack > 0.0)) l->slack = envlt__measure_unevenness(f);
    for (t = 0; t < f->g->count; t++, x = x + 1 < f->g->width ? x + 1 : 0)
        f->label[t] = l->strata[envlt__map_texel(f->g, t - x, x)];
    if (l->desc.split_sun) envlt__follow_sun(f);
    envlt__sum_strata(f);
    while (envlt__change_count(f, k)) {}
    envlt__rebalance_strata(f, 2.0 * l->slack);
}

/* Measures the angles between lights of equal id, before and after, weighted by energy. */
static void envlt__measure_moves(const envlt_lights *l, const envlt_light *before, uint32_t count,
                                 envlt_stats *stats)
{
    uint32_t i, j;
    double sum = 0.0, weight = 0.0;
    for (i = 0; i < l->count; i++) {
        const envlt_light *a = &l->list[i];
        float angle;
        double w = (double)envlt__luminance(a->irradiance);
        for (j = 0; j < count && before[j].id != a->id; j++) {}
        if (j == count) continue;
        angle = 2.0f * envlt__asin(0.5f * envlt__v3_length(envlt__v3_sub(envlt__v3_load(a->direction),
                                                                       envlt__v3_load(before[j].direction))));
        if (angle > stats->largest_move) stats->largest_move = angle;
        sum += w * (double)angle;
        weight += w;
    }
    stats->mean_move = weight > 0.0 ? (float)(sum / weight) : 0.0f;
}

/* Builds all lights anew in place, after a map that was black or had too few lit texels for them. */
static envlt_result envlt__rebuild_lights(envlt_lights *l, const envlt_map *map, uint32_t k,
                                          envlt_stats *stats)
{
    envlt_lights *fresh, kept;
    envlt_desc d = l->desc;
    envlt_stats s;
    envlt_result result;
    uint32_t i;
    d.light_count = k;
    result = envlt__make_lights(&d, map, l->texels, &fresh, &s);
    if (result != ENVLT_OK) return result;
    kept = *l;
    *l = *fresh;
    *fresh = kept;
    l->allocator.user = &l->meter;
    fresh->allocator.user = &fresh->meter;
    for (i = 0; i < l->count; i++) l->list[i].id = kept.next_id + i;
    l->next_id = kept.next_id + l->count;
    envlt_free(fresh);
    s.changed = l->count;
    s.peak_bytes += kept.meter.now;         /* both are there at once */
    if (stats) *stats = s;
    return ENVLT_OK;
}

/* Allocates what a follow needs beside the grid, with room for `most` lights. Returns 0 if there is no
   memory; the caller calls envlt__close_follow in any case. */
static int envlt__open_follow(envlt__follow *f, uint32_t most)
{
    const envlt_lights *l = f->l;
    const size_t texels = l->texels;
    const envlt__allocator *a = &l->allocator;
    f->label = (uint32_t *)envlt__alloc_array(a, texels, sizeof *f->label);
    f->partner = (uint32_t *)envlt__alloc_array(a, most, sizeof *f->partner);
    f->cost = (double *)envlt__alloc_array(a, most, sizeof *f->cost);
    f->gain = (double *)envlt__alloc_array(a, most, sizeof *f->gain);
    f->touched = (uint8_t *)envlt__alloc(a, most);
    f->before = (envlt_light *)envlt__alloc_array(a, l->count, sizeof *f->before);
    if (l->desc.split_sun) {
        f->queue = (uint32_t *)envlt__alloc_array(a, texels, sizeof *f->queue);
        f->seen = (uint8_t *)envlt__alloc(a, texels);
    }
    if (!f->label || !f->partner || !f->cost || !f->gain || !f->touched || !f->before) return 0;
    return !l->desc.split_sun || (f->queue && f->seen);
}

static void envlt__close_follow(envlt__follow *f)
{
    const envlt__allocator *a = &f->l->allocator;
    envlt__free(a, f->seen);
    envlt__free(a, f->queue);
    envlt__free(a, f->before);
    envlt__free(a, f->touched);
    envlt__free(a, f->gain);
    envlt__free(a, f->cost);
    envlt__free(a, f->partner);
    envlt__free(a, f->label);
}

/* Returns whether an earlier map, nearly black, had too few lit texels for k lights, and this map has more.
   */
static int envlt__has_more_texels(const envlt__follow *f, uint32_t k)
{
    const envlt_lights *l = f->l;
    size_t lit;
    uint32_t sun;
    if (!l->lit || k <= l->count) return 0;
    lit = envlt__count_lit(f->g, NULL);
    sun = l->desc.split_sun ? envlt__find_sun(f->g, k, f->queue, f->seen) : 0;
    return lit - sun + (sun ? 1 : 0) > l->lit;
}

ENVLT_DEF envlt_result envlt_follow(envlt_lights *l, const envlt_map *map, uint32_t light_count,
                                    envlt_stats *stats)
{
    envlt__follow f;
    envlt__grid g;
    uint32_t k, asked, old, most;
    envlt__logger logger;
    envlt_result result;
    int anew;

    if (!l) return ENVLT_ERR_ARGUMENT;
    logger = envlt__make_logger(&l->desc.system, "envlt_follow");
    if (light_count > ENVLT_MAX_LIGHTS)
        return envlt__refuse(&logger, "light_count", light_count, "0 (as before) or 1..8192",
                             ENVLT_ERR_ARGUMENT);
    result = envlt__check_same(l, map, &logger);
    if (result != ENVLT_OK) return result;
    k = light_count ? light_count : l->count;
    asked = light_count || (l->count && !l->lit) ? k : l->desc.light_count;
    if (!l->count) return envlt__end_call(&logger, envlt__rebuild_lights(l, map, asked, stats));
    memset(&f, 0, sizeof f);
    memset(&g, 0, sizeof g);
    old = l->count;
    most = (k > old ? k : old) + 1;
    l->meter.peak = l->meter.now;
    f.l = l;
    f.g = &g;
    result = envlt__make_grid(&g, map, l->desc.hemisphere, l->roll, &l->allocator);
    if (!envlt__open_follow(&f, most)) result = ENVLT_ERR_ALLOC;
    anew = result == ENVLT_OK && envlt__has_more_texels(&f, asked);
    if (result == ENVLT_OK && !anew && !envlt__reserve_lights(l, most)) result = ENVLT_ERR_ALLOC;
    if (result == ENVLT_OK && !anew) {
        memcpy(f.before, l->list, old * sizeof *f.before);
        l->desc.light_count = asked;
        envlt__run_follow(&f, k);
        envlt__fill_lights(l, &g, NULL);
        envlt__fill_cdf(l, &g);
        if (stats) {
            envlt__fill_stats(l, &g, stats);
            stats->changed = f.changed;
            envlt__measure_moves(l, f.before, old, stats);
        }
    }
    envlt__close_follow(&f);
    envlt__free(&l->allocator, g.memory);
    if (anew) result = envlt__rebuild_lights(l, map, asked, stats);
    return envlt__end_call(&logger, result);
}

/* ==== src/envlights/match.h ==== */

/* ---- match: lights of another build, or of a turned sky ---- */

static void envlt__swap_lights(envlt_light *lights, uint32_t a, uint32_t b)
{
    envlt_light moved = lights[a];
    lights[a] = lights[b];
    lights[b] = moved;
}

/* Returns the light that follows `last` in the order of falling luminance, equal ones in the order of the
   list. *bright is the luminance of `last`; the first call is made with infinity and ENVLT_NO_LIGHT. */
static uint32_t envlt__next_brightest(const envlt_light *list, uint32_t count, float *bright, uint32_t last)
{
    uint32_t i, best = ENVLT_NO_LIGHT;
    float most = 0.0f;
    for (i = 0; i < count; i++) {
        float w = envlt__luminance(list[i].irradiance);
        w = w > 0.0f ? w : 0.0f;                    /* NaN counts as 0 too */
        if (w > *bright || (!(w < *bright) && last != ENVLT_NO_LIGHT && i <= last)) continue;
        if (best != ENVLT_NO_LIGHT && w <= most) continue;
        most = w;
        best = i;
    }
    *bright = most;
    return best;
}

/* Returns whether the directions of all lights are unit, 0 0 0 or not finite, by the rule of all headers. */
static int envlt__directions_fit(const envlt_light *lights, uint32_t count)
{
    uint32_t i;
    for (i = 0; i < count; i++) {
        envlt__v3 d = envlt__v3_load(lights[i].direction);
        float square = envlt__v3_dot(d, d);
        if (square > 0.0f && !envlt__is_unit2(square) && envlt__v3_finite(d)) return 0;
    }
    return 1;
}

ENVLT_DEF envlt_result envlt_match(const envlt_light *previous, uint32_t previous_count, envlt_light *lights,
                                   uint32_t count)
{
    uint32_t i, j;
    uint32_t next = 0;
    uint32_t kept = previous_count < count ? previous_count : count;
    uint32_t which = ENVLT_NO_LIGHT;
    float bright = envlt__from_bits(0x7f800000u);
    if ((!previous && previous_count) || (!lights && count)) return ENVLT_ERR_ARGUMENT;
    if (!envlt__directions_fit(previous, previous_count) || !envlt__directions_fit(lights, count))
        return ENVLT_ERR_INPUT;
    for (i = 0; i < previous_count; i++)
        if (previous[i].id >= next) next = previous[i].id + 1;
    /* First the lights that found a previous one come to the front, with its place in their ids. */
    for (i = 0; i < kept; i++) {
        uint32_t best = i;
        float most = -2.0f;
        which = envlt__next_brightest(previous, previous_count, &bright, which);
        for (j = i; j < count; j++) {
            float c = envlt__v3_dot(envlt__v3_load(previous[which].direction),
                                    envlt__v3_load(lights[j].direction));
            if (c > most) {
                most = c;
                best = j;
            }
        }
        envlt__swap_lights(lights, i, best);
        lights[i].id = which;
    }
    /* Then each goes to that place. A place below `kept` that nobody has gets the light with the lowest place
       among those whose own place is gone. */
    for (i = 0; i < kept; i++) {
        uint32_t best = ENVLT_NO_LIGHT;
        for (j = i; j < kept && (best == ENVLT_NO_LIGHT || lights[best].id != i); j++)
            if (lights[j].id == i || (lights[j].id >= kept && (best == ENVLT_NO_LIGHT ||
                                                               lights[j].id < lights[best].id))) best = j;
        envlt__swap_lights(lights, i, best);
    }
    for (i = 0; i < kept; i++) lights[i].id = previous[lights[i].id].id;
    for (; i < count; i++) lights[i].id = next++;
    return ENVLT_OK;
}

ENVLT_DEF envlt_result envlt_rotate(envlt_light *lights, uint32_t count, const float matrix[16])
{
    float scale;
    uint32_t i;
    if ((!lights && count) || !matrix) return ENVLT_ERR_ARGUMENT;
    if (!envlt__m4_is_rigid_uniform(matrix, &scale) || !(fabsf(scale - 1.0f) < 1e-3f))
        return ENVLT_ERR_INPUT;
    if (!envlt__directions_fit(lights, count)) return ENVLT_ERR_INPUT;
    scale = 1.0f / scale;
    for (i = 0; i < count; i++) {
        envlt_light *l = &lights[i];
        envlt__v3_store(l->direction,
                        envlt__v3_normalize(envlt__m4_direction(matrix, envlt__v3_load(l->direction))));
        envlt__v3_store(l->axis_u,
                        envlt__v3_scale(envlt__m4_direction(matrix, envlt__v3_load(l->axis_u)), scale));
        envlt__v3_store(l->axis_v,
                        envlt__v3_scale(envlt__m4_direction(matrix, envlt__v3_load(l->axis_v)), scale));
    }
    return ENVLT_OK;
}

/* ==== src/envlights/gltf.h ==== */

/* ---- gltf: text without the C library, whose numbers depend on the locale ---- */

/* A text that is written, or only measured: length goes on where size ends. */
typedef struct envlt__text { char *out; size_t size, length; } envlt__text;

static void envlt__put_text(envlt__text *t, const char *s)
{
    for (; *s; s++, t->length++)
        if (t->length + 1 < t->size) t->out[t->length] = *s;
}

static void envlt__put_unsigned(envlt__text *t, uint32_t v)
{
    char digits[11];
    int n = 10;
    digits[n] = 0;
    do {
        digits[--n] = (char)('0' + v % 10u);
        v /= 10u;
    } while (v);
    envlt__put_text(t, digits + n);
}

/* Writes a number with nine significant digits, from which the same float can be read back. JSON has no word
   for infinity and NaN, which are written as 0. */
static void envlt__put_float(envlt__text *t, float f)
{
    double v = (double)f;
    int exponent = 0;
    char one[2] = { 0, 0 };
    uint32_t digits, scale;
    if (v < 0.0 && envlt__finite(f)) {
        envlt__put_text(t, "-");
        v = -v;
    }
    if (!(v > 0.0) || !envlt__finite(f)) {
        envlt__put_text(t, "0");
        return;
    }
    while (v >= 999999999.5) {
        v /= 10.0;
        exponent++;
    }
    while (v < 99999999.95) {
        v *= 10.0;
        exponent--;
    }
    digits = (uint32_t)(v + 0.5);
    if (digits > 999999999u) digits = 999999999u;
    exponent += 8;
    for (scale = 100000000u; scale; scale /= 10u) {
        one[0] = (char)('0' + digits / scale % 10u);
        envlt__put_text(t, one);
        if (scale == 100000000u) envlt__put_text(t, ".");
    }
    envlt__put_text(t, exponent < 0 ? "e-" : "e");
    envlt__put_unsigned(t, (uint32_t)(exponent < 0 ? -exponent : exponent));
}

static void envlt__put_floats(envlt__text *t, const float *v, int n)
{
    int i;
    envlt__put_text(t, "[");
    for (i = 0; i < n; i++) {
        if (i) envlt__put_text(t, ",");
        envlt__put_float(t, v[i]);
    }
    envlt__put_text(t, "]");
}

/* Writes a node. A light of glTF shines along the -Z of its node, so the node's rotation, a quaternion x y z
   w, is the shortest turn that brings +Z to the light's direction. */
static void envlt__put_node(envlt__text *t, const envlt_light *l, uint32_t i)
{
    envlt__v3 d = envlt__v3_load(l->direction);
    float q[4], length;
    q[0] = -d.y;
    q[1] = d.x;
    q[2] = 0.0f;
    q[3] = 1.0f + d.z;
    if (!(q[3] > 1e-6f)) {
        q[0] = 1.0f;
        q[1] = q[2] = q[3] = 0.0f;
    }
    length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[3] * q[3]);
    q[0] /= length;
    q[1] /= length;
    q[3] /= length;
    envlt__put_text(t, i ? ",\n" : "\n");
    envlt__put_text(t, "{\"rotation\":");
    envlt__put_floats(t, q, 4);
    envlt__put_text(t, ",\"extensions\":{\"KHR_lights_punctual\":{\"light\":");
    envlt__put_unsigned(t, i);
    envlt__put_text(t, "}}}");
}

static void envlt__put_light(envlt__text *t, const envlt_light *l, uint32_t i)
{
    float color[3], most = l->irradiance[0];
    int c;
    for (c = 1; c < 3; c++)
        if (l->irradiance[c] > most) most = l->irradiance[c];
    for (c = 0; c < 3; c++) color[c] = most > 0.0f ? l->irradiance[c] / most : 1.0f;
    envlt__put_text(t, i ? ",\n" : "\n");
    envlt__put_text(t, "{\"type\":\"directional\",\"color\":");
    envlt__put_floats(t, color, 3);
    envlt__put_text(t, ",\"intensity\":");
    envlt__put_float(t, most);
    envlt__put_text(t, "}");
}

static void envlt__put_document(envlt__text *t, const envlt_light *lights, uint32_t count)
{
    uint32_t i;
    envlt__put_text(t, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"envlights.h\"}");
    if (count) {
        envlt__put_text(t, ",\n\"extensionsUsed\":[\"KHR_lights_punctual\"],\n"
                       "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[");
        for (i = 0; i < count; i++) envlt__put_light(t, &lights[i], i);
        envlt__put_text(t, "]}},\n\"nodes\":[");
        for (i = 0; i < count; i++) envlt__put_node(t, &lights[i], i);
        envlt__put_text(t, "],\n\"scene\":0,\"scenes\":[{\"nodes\":[");
        for (i = 0; i < count; i++) {
            if (i) envlt__put_text(t, ",");
            envlt__put_unsigned(t, i);
        }
        envlt__put_text(t, "]}]");
    }
    envlt__put_text(t, "}\n");
}

ENVLT_DEF size_t envlt_gltf_bytes(const envlt_light *lights, uint32_t count)
{
    envlt__text t;
    if (!lights) return 0;
    memset(&t, 0, sizeof t);
    envlt__put_document(&t, lights, count);
    return t.length + 1;
}

ENVLT_DEF envlt_result envlt_gltf_write(const envlt_light *lights, uint32_t count, char *text, size_t bytes)
{
    envlt__text t;
    if (!lights || !text) return ENVLT_ERR_ARGUMENT;
    if (!envlt__directions_fit(lights, count)) return ENVLT_ERR_INPUT;
    if (bytes < envlt_gltf_bytes(lights, count)) return ENVLT_ERR_MEMORY;
    t.out = text;
    t.size = bytes;
    t.length = 0;
    envlt__put_document(&t, lights, count);
    text[t.length] = 0;
    return ENVLT_OK;
}

/* ==== src/envlights/residual.h ==== */

/* ---- residual: what the lights leave out ---- */

/* Checks the arguments of a residual. `name` is that of the output, for the log. */
static envlt_result envlt__check_residual(const envlt_lights *l, const envlt_map *map, const char *function,
                                          const char *name, const float *out)
{
    envlt__logger logger;
    if (!l) return ENVLT_ERR_ARGUMENT;
    logger = envlt__make_logger(&l->desc.system, function);
    return out ? envlt__check_same(l, map, &logger)
               : envlt__refuse_text(&logger, name, "is NULL", ENVLT_ERR_ARGUMENT);
}

ENVLT_DEF envlt_result envlt_residual(const envlt_lights *l, const envlt_map *map, float *rgb)
{
    envlt_result result = envlt__check_residual(l, map, "envlt_residual", "rgb", rgb);
    float texel[3];
    size_t t, c;
    if (result != ENVLT_OK) return result;
    for (t = 0; t < l->texels; t++) {
        uint32_t s = l->strata[t];
        envlt__fetch_texel(map, t, texel);
        for (c = 0; c < 3; c++)
            rgb[3 * t + c] = s == ENVLT_NO_LIGHT ? 0.0f
                                                 : (float)((double)texel[c] -
                                                           l->sums[s].rgb[c] / l->sums[s].omega);
    }
    return ENVLT_OK;
}

/* Writes the nine real spherical harmonics of bands 0, 1 and 2 in a unit direction. */
static void envlt__fill_harmonics(const double *d, double *y)
{
    y[0] = 0.28209479177387814;
    y[1] = 0.48860251190291992 * d[1];
    y[2] = 0.48860251190291992 * d[2];
    y[3] = 0.48860251190291992 * d[0];
    y[4] = 1.0925484305920792 * d[0] * d[1];
    y[5] = 1.0925484305920792 * d[1] * d[2];
    y[6] = 0.31539156525252005 * (3.0 * d[2] * d[2] - 1.0);
    y[7] = 1.0925484305920792 * d[0] * d[2];
    y[8] = 0.54627421529603959 * (d[0] * d[0] - d[1] * d[1]);
}

ENVLT_DEF envlt_result envlt_residual_sh(const envlt_lights *l, const envlt_map *map, float sh[27])
{
    envlt_result result = envlt__check_residual(l, map, "envlt_residual_sh", "sh", sh);
    double sum[27], y[9], d[3], omega = 0.0;
    uint32_t w, h, x, row;
    uint32_t face, i, j, c;
    size_t t = 0;
    if (result != ENVLT_OK) return result;
    memset(sum, 0, sizeof sum);
    w = map->width;
    h = map->height;
    for (row = 0; row < l->texels / w; row++) {
        face = row / h;
        for (x = 0; x < w; x++, t++) {
            float rgb[3];
            if (l->strata[t] == ENVLT_NO_LIGHT) continue;
            if (x == 0 || l->map.projection == ENVLT_PROJECTION_CUBE || !(omega > 0.0))
                omega = envlt__solid_angle(map, face, x, row % h, l->desc.hemisphere);
            envlt__fetch_texel(map, t, rgb);
            if (!(rgb[0] + rgb[1] + rgb[2] > 0.0f)) continue;
            envlt__direction(map, face, x + 0.5, row % h + 0.5, d);
            envlt__fill_harmonics(d, y);
            for (j = 0; j < 27; j++) sum[j] += y[j / 3] * omega * (double)rgb[j % 3];
        }
        omega = 0.0;
    }
    for (i = 0; i < l->count; i++) {
        for (c = 0; c < 3; c++) d[c] = (double)l->list[i].direction[c];
        envlt__fill_harmonics(d, y);
        for (j = 0; j < 27; j++) sum[j] -= y[j / 3] * l->sums[i].rgb[j % 3];
    }
    for (j = 0; j < 27; j++) sh[j] = (float)sum[j];
    return ENVLT_OK;
}

ENVLT_DEF void envlt_sh_irradiance(const float sh[27], const float normal[3], float rgb[3])
{
    /* The clamped cosine in the three bands: pi, 2 pi / 3 and pi / 4 (T10). */
    static const double kernel[9] = { 3.1415926535897932,
                                      2.0943951023931953, 2.0943951023931953, 2.0943951023931953,
                                      0.78539816339744831, 0.78539816339744831, 0.78539816339744831,
                                      0.78539816339744831, 0.78539816339744831 };
    double d[3], y[9], sum;
    int c, j;
    for (c = 0; c < 3; c++) d[c] = (double)normal[c];
    envlt__fill_harmonics(d, y);
    for (c = 0; c < 3; c++) {
        sum = 0.0;
        for (j = 0; j < 9; j++) sum += kernel[j] * y[j] * (double)sh[3 * j + c];
        rgb[c] = (float)sum;
    }
}

/* ==== src/shared/fp_end.h ==== */

/* unit fp_end: the user's options again. clang and MSVC keep contraction off to the end of the file. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__)
#pragma GCC pop_options
#endif

/* ==== src/envlights/end.h ==== */

#endif /* ENVLIGHTS_IMPLEMENTATION */

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
