/* gifilter.h - v1.0.0 - noisy pictures of light made smooth over frames and neighbours - MIT-0 OR Unlicense

   What it does

   This header smooths noisy pictures of light, such as bounced light from few samples. It takes one picture
   each frame, with the place and the normal of what every pixel shows. It first adds what the frames before
   knew of the same surfaces (temporal accumulation with reprojection), and then takes means of neighbours on
   the same surface (the a-trous filter of Dammertz, Sewtz, Hanika and Lensch, "Edge-Avoiding A-Trous Wavelet
   Transform for fast Global Illumination Filtering", HPG 2010). The light may come from rsm.h with few
   samples, from ism.h with few lights, or from a path tracer.

   What it does not do

   - Textures would be blurred: give the light (irradiance), and multiply by the albedo afterwards.
   - Motion is not looked for: surfaces are found in the last frame by that frame's matrix, or where you say.
   - The header renders no pictures, starts no threads and opens no files.

   Quick start

   In exactly one source file write the define; everywhere else include the header alone.

       #define GIFILTER_IMPLEMENTATION
       #include "gifilter.h"
       #include <stdio.h>

       enum { W = 64, H = 48, FRAMES = 8 };
       static float positions[3 * W * H], normals[3 * W * H], light[3 * W * H];

       int main(void)
       {
           // The camera looks along -z at a wall, which covers the picture: clip x and y are the world's.
           static const float world_to_clip[16] = { 1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1 };
           static gifilt_desc size;                         // static: all zero, the defaults
           static gifilt_frame settings;
           static gifilt_points points;
           gifilt_filter *filter;
           uint32_t random = 1;
           double before = 0, after = 0;
           int frame, i;

           for (i = 0; i < W * H; i++) {
               positions[3 * i] = ((float)(i % W) + 0.5f) * 2.0f / W - 1.0f;
               positions[3 * i + 1] = ((float)(i / W) + 0.5f) * 2.0f / H - 1.0f;
               normals[3 * i + 2] = 1;
           }
           points.count = W * H;
           points.positions = positions;
           points.normals = normals;
           settings.world_to_clip = world_to_clip;
           size.width = W;
           size.height = H;
           if (gifilt_create(&size, &filter) != GIFILT_OK) return 1;
           for (frame = 0; frame < FRAMES; frame++) {
               before = after = 0;
               for (i = 0; i < 3 * W * H; i++) {             // the light is 1; a sample is 0 to 2
                   random = random * 1664525u + 1013904223u;
                   light[i] = (float)(random >> 8) / 8388608.0f;
                   before += ((double)light[i] - 1) * ((double)light[i] - 1);
               }
               if (gifilt_apply(filter, &settings, &points, light, light) != GIFILT_OK) return 1;
               for (i = 0; i < 3 * W * H; i++) after += ((double)light[i] - 1) * ((double)light[i] - 1);
           }
           printf("variance %.4f, filtered %.4f\n", before / (3 * W * H), after / (3 * W * H));
           gifilt_free(filter);
           return !(after < 0.05 * before);
       }

   Conventions

   Space is right-handed. Matrices are column-major float[16]. Distances are in your units. Colours are
   linear, three floats r, g, b. Pictures lie row by row; gifilt_frame.rows says which row comes first.
   Normals called unit may be 0.97 to 1.03 long and are used as they are; any other length is an error, but
   for 0 0 0 and normals that are not finite, whose pixels show nothing.

   How it works

     gifilt_create -> each frame: gifilt_apply -> ... -> gifilt_free;  after a cut: gifilt_reset

   gifilt_apply, step by step:

     - Each pixel's place is projected by the last frame's matrix, or moved by the pixel's motion. The four
       pixels of the last frame about that point count, with bilinear weights, if they show the same surface:
       not farther away than four of this frame's pixels are wide, not off the plane, with a like normal.
     - The light that those pixels knew is mixed with the new light, which counts as 1 of n frames; n grows
       by 1 each frame, up to the frame's history.
     - Each pass takes the mean of 3 x 3 pixels, which are 1 pixel apart in the first pass, 2 in the second, 4
       in the third. Their weights are 1 2 1 by 1 2 1, times a factor from 0 to 1 that says whether they show
       the same surface.

   A filter takes 80 bytes a pixel and 4 KB a row; gifilt_apply allocates nothing. The knobs, and what each
   trades:

     history    more: less noise, and light that moves lags behind. 8 is mostly enough
     passes     more: less noise, and light is blurred where it falls off beside corners. 1 or 2 are mostly
                enough
     normal_cosine   more: edges and fine shapes stay sharp, and fewer neighbours help
     plane_slope     less: as with more normal_cosine, for neighbours that lie before or behind the surface

   From the paper to the code

     section 2    a kernel with holes, twice as wide in each pass     gifilt__smooth                    -
     section 2.1  weights that stop at edges of normals and depths    gifilt__alike                     -
     -            temporal accumulation with reprojection             gifilt__accumulate                -

   No row of docs/conformance.md belongs to a filter of pictures; tests/gifilter/sums_test.c computes all
   three anew in doubles. The knobs of the first two are passes, normal_cosine and plane_slope in
   gifilt_frame, that of the last one, which the paper does not have, is history.

   Where this departs from the paper

     - The kernel is 3 x 3 (1 2 1), not 5 x 5 (1 4 6 4 1): with two passes every one of 4 x 4 interleaved
       sample sets counts alike, with three of 8 x 8. A larger kernel costs three times as much.
     - Colours are not compared, since noise looks like an edge of light.
     - Weights fall to 0 at a cosine and at a slope off the plane, where the paper has exponentials.
     - A pixel with few neighbours like it is made no brighter than its brightest neighbour
       (docs/gifilter.md).

   Configuration

     GIFILTER_IMPLEMENTATION   in one source file: compiles the code
     GIFILT_STATIC             beside it: a private copy for this file, all functions static
     GIFILT_DEF                everywhere: your own linkage instead
     GIFILT_NO_SIMD            with the implementation: portable code only (results are the same to the bit)
     GIFILT_FILE               with the implementation: this file's name, if it is not "gifilter.h". The file
                               includes itself for AVX2 and AVX-512; where it cannot, it does without them

   Memory, errors, threads, determinism

   All memory comes from the allocator in the system, called from the thread that called us. Every function
   that can fail returns a gifilt_result. If the result is not GIFILT_OK, outputs are untouched, nothing
   leaks, and the system's log gets one line that names the field or element, its value and its range. Only a
   call whose desc or filter is NULL has no log. There are no globals; a filter belongs to one thread at a
   time. The same input gives the same bytes on every compiler, processor, byte order and thread count (not
   with x87 arithmetic, nor with clang's -ffast-math).

   Cost: docs/gifilter.md.   History: CHANGELOG.md.   Licence: end of this file. */
#ifndef GIFILTER_H
#define GIFILTER_H

#define GIFILT_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "gifilter.h needs C99 or C++11"
#endif
#if defined(GIFILT_STATIC) && !defined(GIFILTER_IMPLEMENTATION)
#error "GIFILT_STATIC makes all functions private: GIFILTER_IMPLEMENTATION belongs into the same file"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef GIFILT_DEF
#ifdef GIFILT_STATIC
#define GIFILT_DEF static inline
#else
#define GIFILT_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/gifilter/api.h ==== */

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

/* ==== src/gifilter/begin.h ==== */

/* ==== implementation ==================================================================================== */

#if defined(GIFILTER_IMPLEMENTATION) && !defined(GIFILTER_IMPLEMENTED)

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The name of this file, by which it includes itself (see kernels_begin.h). Define GIFILT_FILE if you renamed
   it. */
#ifndef GIFILT_FILE
#define GIFILT_FILE "gifilter.h"
#endif
#define GIFILT__FILE GIFILT_FILE

#ifdef GIFILT_NO_SIMD
#define GIFILT__NO_SIMD
#endif

/* ==== src/shared/fp_begin.h ==== */

/* unit fp_begin: the arithmetic that the bytes depend on, from here to unit fp_end */

/* Forbids fused multiply-adds that the source does not ask for: gcc fuses across statements in its gnu modes
   and on s390x, clang within expressions. For gcc, the pragmas take a user's -ffast-math back. In clang,
   -ffast-math and -ffp-contract=fast win over the pragma: results then stay within tolerance, but are not
   equal to the bit. */
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#define GIFILT__FINITE_MATH 1
#else
#define GIFILT__FINITE_MATH 0
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

typedef struct gifilt__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} gifilt__allocator;

static inline void *gifilt__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void gifilt__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
static inline int gifilt__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

static inline int gifilt__add_size(size_t a, size_t b, size_t *out)
{
    if (a > SIZE_MAX - b) return 0;
    *out = a + b;
    return 1;
}

/* Returns 1 if so many bytes may lie between elements of floats that are `standard` bytes large: 0, which
   stands for `standard`, or a multiple of 4 with which elements do not overlap. */
static inline int gifilt__stride_valid(size_t stride, size_t standard)
{
    return stride == 0 || (stride >= standard && stride % 4 == 0);
}

/* Returns 1 if the functions of a public allocator are both there or both NULL. */
static inline int gifilt__allocator_valid(void *(*alloc_fn)(size_t, void *), void (*free_fn)(void *, void *))
{
    return (alloc_fn == NULL) == (free_fn == NULL);
}

static inline gifilt__allocator gifilt__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    gifilt__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : gifilt__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : gifilt__default_free;
    a.user = user;
    return a;
}

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *gifilt__alloc(const gifilt__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *gifilt__alloc_array(const gifilt__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return gifilt__mul_size(count, item_size, &size) ? gifilt__alloc(a, size) : NULL;
}

static inline void gifilt__free(const gifilt__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/v3.h ==== */

/* unit v3: three floats */

/* tcc 0.9.27 stores a returned struct of 12 bytes as 16, over the caller's next variable. */
typedef struct gifilt__v3 {
    float x, y, z;
#ifdef __TINYC__
    float unused;
#endif
} gifilt__v3;

static inline gifilt__v3 gifilt__v3_make(float x, float y, float z)
{
    gifilt__v3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

static inline gifilt__v3 gifilt__v3_load(const float *p) { return gifilt__v3_make(p[0], p[1], p[2]); }

static inline float gifilt__v3_dot(gifilt__v3 a, gifilt__v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float gifilt__v3_length(gifilt__v3 a)
{
    return sqrtf(gifilt__v3_dot(a, a));
}

/* Returns 1 if x is finite, by its exponent bits: under -ffast-math compilers may take isfinite() for always
   true. */
static inline int gifilt__finite(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7f800000u) != 0x7f800000u;
}

/* ==== src/shared/unit.h ==== */

/* unit unit: which vectors count as unit, the same in every header (src/README.md, "Unit vectors") */

/* The squares of the least and the greatest length that count as 1: an 8-bit normal map makes such
   vectors. */
#define GIFILT__UNIT_LEAST2 0.9409f       /* 0.97^2 */
#define GIFILT__UNIT_MOST2 1.0609f        /* 1.03^2 */

/* Says whether a vector is unit, by the square of its length. If that is not a number, the vector is not. */
static inline int gifilt__is_unit2(float length2)
{
    return length2 >= GIFILT__UNIT_LEAST2 && length2 <= GIFILT__UNIT_MOST2;
}

/* ==== src/shared/cpu.h ==== */

/* unit cpu: run-time detection of x86 vector units */

/* GIFILT__X86 is 1 if functions with target attributes can be compiled and chosen at run time. GIFILT__NO_SIMD, which
   the header defines from its public switch, makes it 0. tcc has no such attributes, so that it is 0 there;
   MSVC needs none. For clang in MSVC's place (clang-cl) it is 0, since this compiler hides the vector types
   unless the whole program is built for them. */
#if defined(GIFILT__NO_SIMD) || defined(__TINYC__)
#define GIFILT__X86 0
#elif defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
#define GIFILT__X86 1
#define GIFILT__TARGET_AVX2 __attribute__((target("avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#define GIFILT__TARGET_AVX512 \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#elif defined(_MSC_VER) && defined(_M_X64) && !defined(__clang__)
#define GIFILT__X86 1
#define GIFILT__TARGET_AVX2
#define GIFILT__TARGET_AVX512
#else
#define GIFILT__X86 0
#endif

/* These ask the processor directly: the compilers' own functions ask the same, but add 4.5 KB to every
   program. */
#if GIFILT__X86 && defined(_MSC_VER)
#include <intrin.h>
static inline void gifilt__cpu_ask(unsigned leaf, unsigned *r) { __cpuidex((int *)r, (int)leaf, 0); }
static inline unsigned gifilt__cpu_xcr0(void) { return (unsigned)_xgetbv(0); }
#elif GIFILT__X86
#include <cpuid.h>
static inline void gifilt__cpu_ask(unsigned leaf, unsigned *r)
{
    __cpuid_count(leaf, 0, r[0], r[1], r[2], r[3]);
}
static inline unsigned gifilt__cpu_xcr0(void)
{
    unsigned low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}
#endif

#if GIFILT__X86
/* Returns 1 if all of these bits are set in ebx of cpuid's leaf 7, the processor has FMA and POPCNT, and the
   operating system saves the registers that the bits of xcr0 stand for. Every processor with BMI2 has
   LZCNT. */
static inline int gifilt__cpu_leaf7(unsigned xcr0, unsigned ebx)
{
    const unsigned wanted = 1u << 12 | 1u << 23 | 1u << 27;     /* FMA, POPCNT, OSXSAVE */
    unsigned r[4];
    gifilt__cpu_ask(0, r);
    if (r[0] < 7) return 0;
    gifilt__cpu_ask(1, r);
    if ((r[2] & wanted) != wanted || (gifilt__cpu_xcr0() & xcr0) != xcr0) return 0;
    gifilt__cpu_ask(7, r);
    return (r[1] & ebx) == ebx;
}
/* Asks for AVX2, BMI and BMI2, and for the registers of SSE and AVX. */
static inline int gifilt__cpu_has_avx2(void) { return gifilt__cpu_leaf7(0x06u, 0x00000128u); }
/* Asks for F, DQ, BW and VL of AVX-512 besides, and for its mask registers and wide registers. */
static inline int gifilt__cpu_has_avx512(void) { return gifilt__cpu_leaf7(0xe6u, 0xc0030128u); }
#else
static inline int gifilt__cpu_has_avx2(void) { return 0; }
static inline int gifilt__cpu_has_avx512(void) { return 0; }
#endif

/* ==== src/shared/hot.h ==== */

/* unit hot, needs fp_begin: attributes of functions that take most of the time */

/* GIFILT__HOT stands before functions that gcc is to optimise as with -O3. It is nothing under -ffast-math, since
   gcc's -O3 for single functions forgets that unit fp_begin took -ffast-math back, and with the address
   sanitizer, with which -O3 of a kernel takes twice as long as everything else. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__) && defined(__OPTIMIZE__) && \
    !defined(__SANITIZE_ADDRESS__) && !GIFILT__FINITE_MATH
#define GIFILT__HOT __attribute__((optimize("O3")))
#else
#define GIFILT__HOT
#endif

/* GIFILT__INLINE stands before what must be inlined into kernels of several targets. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define GIFILT__INLINE static inline __attribute__((always_inline))
#elif defined(_MSC_VER)
#define GIFILT__INLINE static __forceinline
#else
#define GIFILT__INLINE static inline
#endif

#if defined(__GNUC__) && !defined(__TINYC__)
#define GIFILT__PREFETCH(p) __builtin_prefetch(p)
#else
#define GIFILT__PREFETCH(p) (void)(p)
#endif

/* ==== src/shared/simd.h ==== */

/* unit simd, needs cpu: one text of a kernel for every instruction set */

/* A kernel is written once, for gifilt__lanes: GIFILT__LANE_COUNT floats, of which the instruction set GIFILT__SET
   computes GIFILT__WIDTH at a time. What lies between unit simd_begin and the last kernel of a header is compiled
   once for every set that the program may meet. It is first compiled in its place, as set "plain", for what
   the whole program is compiled for (SSE2, NEON, the 128 bits of WebAssembly, or one float at a time). Then,
   if GIFILT__SIMD_SETS is 1, the header includes itself with GIFILT__SET, GIFILT__WIDTH and GIFILT__LANE_COUNT defined
   anew: avx2 with 8 lanes, avx512 with 16. gifilt__simd_level returns which set to call. With GIFILT__NO_SIMD there
   are no intrinsics; the compiler's own vectors, which are portable, stay if GIFILT__COMPILER_VECTORS is
   defined. GIFILT__FILE is the header's name; a header pasted into another file cannot include itself: "plain".

   What is compiled several times needs a name for each set. The list below makes gifilt__lanes_add the name
   gifilt__lanes_add_avx2 in set avx2; the header has such a list for its kernels. GIFILT__KERNEL stands before a
   kernel, GIFILT__IN_KERNEL before what is inlined into kernels.

   Every set gives the same bits, but for gifilt__lanes_muladd, which rounds once in avx2 and avx512, twice
   elsewhere. */
#if defined(GIFILT__NO_SIMD) && (!defined(GIFILT__COMPILER_VECTORS) || defined(__i386__))
#define GIFILT__SCALAR 1
#else
#define GIFILT__SCALAR 0
#endif
#if GIFILT__X86
#include <immintrin.h>
#define GIFILT__SIMD_SETS 1
#else
#define GIFILT__SIMD_SETS 0
#endif
#if GIFILT__X86 && (defined(__x86_64__) || defined(_M_X64))
#define GIFILT__SIMD_X86 1
#define GIFILT__SIMD_VECTORS 0
#define GIFILT__SIMD_WIDTH 4
#elif !GIFILT__X86 && !GIFILT__SCALAR && (defined(__GNUC__) || defined(__clang__)) && !defined(__TINYC__)
#define GIFILT__SIMD_X86 0
#define GIFILT__SIMD_VECTORS 1
#define GIFILT__SIMD_WIDTH 4
#else
#define GIFILT__SIMD_X86 0
#define GIFILT__SIMD_VECTORS 0
#define GIFILT__SIMD_WIDTH 1
#endif
#ifdef __has_include
#if !__has_include(GIFILT__FILE)
#undef GIFILT__SIMD_SETS
#define GIFILT__SIMD_SETS 0
#endif
#endif
#if GIFILT__SIMD_VECTORS && defined(__aarch64__) && !defined(GIFILT__NO_SIMD)
#include <arm_neon.h>
#elif GIFILT__SIMD_VECTORS && defined(__wasm_simd128__) && !defined(GIFILT__NO_SIMD)
#include <wasm_simd128.h>
#endif

#define GIFILT__NAME_OF_SET(name, set) name##_##set
#define GIFILT__NAME_IN_SET(name, set) GIFILT__NAME_OF_SET(name, set)
#define gifilt__lanes GIFILT__NAME_IN_SET(gifilt__lanes, GIFILT__SET)
#define gifilt__lane_mask GIFILT__NAME_IN_SET(gifilt__lane_mask, GIFILT__SET)
#define gifilt__lane_ints GIFILT__NAME_IN_SET(gifilt__lane_ints, GIFILT__SET)
#define gifilt__piece GIFILT__NAME_IN_SET(gifilt__piece, GIFILT__SET)
#define gifilt__piece_ints GIFILT__NAME_IN_SET(gifilt__piece_ints, GIFILT__SET)
#define gifilt__piece_words GIFILT__NAME_IN_SET(gifilt__piece_words, GIFILT__SET)
#define gifilt__lanes_load GIFILT__NAME_IN_SET(gifilt__lanes_load, GIFILT__SET)
#define gifilt__lanes_store GIFILT__NAME_IN_SET(gifilt__lanes_store, GIFILT__SET)
#define gifilt__lanes_all GIFILT__NAME_IN_SET(gifilt__lanes_all, GIFILT__SET)
#define gifilt__lanes_add GIFILT__NAME_IN_SET(gifilt__lanes_add, GIFILT__SET)
#define gifilt__lanes_sub GIFILT__NAME_IN_SET(gifilt__lanes_sub, GIFILT__SET)
#define gifilt__lanes_mul GIFILT__NAME_IN_SET(gifilt__lanes_mul, GIFILT__SET)
#define gifilt__lanes_div GIFILT__NAME_IN_SET(gifilt__lanes_div, GIFILT__SET)
#define gifilt__lanes_max GIFILT__NAME_IN_SET(gifilt__lanes_max, GIFILT__SET)
#define gifilt__lanes_min GIFILT__NAME_IN_SET(gifilt__lanes_min, GIFILT__SET)
#define gifilt__lanes_abs GIFILT__NAME_IN_SET(gifilt__lanes_abs, GIFILT__SET)
#define gifilt__lanes_greater GIFILT__NAME_IN_SET(gifilt__lanes_greater, GIFILT__SET)
#define gifilt__lanes_at_least GIFILT__NAME_IN_SET(gifilt__lanes_at_least, GIFILT__SET)
#define gifilt__lanes_differ GIFILT__NAME_IN_SET(gifilt__lanes_differ, GIFILT__SET)
#define gifilt__lanes_select GIFILT__NAME_IN_SET(gifilt__lanes_select, GIFILT__SET)
#define gifilt__lanes_keep GIFILT__NAME_IN_SET(gifilt__lanes_keep, GIFILT__SET)
#define gifilt__lanes_truncate GIFILT__NAME_IN_SET(gifilt__lanes_truncate, GIFILT__SET)
#define gifilt__lanes_of_ints GIFILT__NAME_IN_SET(gifilt__lanes_of_ints, GIFILT__SET)
#define gifilt__lanes3 GIFILT__NAME_IN_SET(gifilt__lanes3, GIFILT__SET)
#define gifilt__lanes3_load GIFILT__NAME_IN_SET(gifilt__lanes3_load, GIFILT__SET)
#define gifilt__lanes3_all GIFILT__NAME_IN_SET(gifilt__lanes3_all, GIFILT__SET)
#define gifilt__lanes3_sub GIFILT__NAME_IN_SET(gifilt__lanes3_sub, GIFILT__SET)
#define gifilt__lanes3_store_packed GIFILT__NAME_IN_SET(gifilt__lanes3_store_packed, GIFILT__SET)
#define gifilt__lanes3_dot GIFILT__NAME_IN_SET(gifilt__lanes3_dot, GIFILT__SET)
#define gifilt__mask_and GIFILT__NAME_IN_SET(gifilt__mask_and, GIFILT__SET)
#define gifilt__mask_or GIFILT__NAME_IN_SET(gifilt__mask_or, GIFILT__SET)
#define gifilt__mask_any GIFILT__NAME_IN_SET(gifilt__mask_any, GIFILT__SET)

/* Returns 2 if AVX-512 may be used, 1 if AVX2 may be, otherwise 0. */
static inline int gifilt__simd_level(void)
{
    if (!GIFILT__SIMD_SETS || !gifilt__cpu_has_avx2()) return 0;
    return gifilt__cpu_has_avx512() ? 2 : 1;
}

/* ==== src/shared/message.h ==== */

/* unit message: one line for the caller's log that says why a call failed */

/* GIFILT__COLD stands before functions that are needed only by calls that fail: compilers make these functions
   small, and take branches to them for unlikely. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define GIFILT__COLD __attribute__((cold))
#else
#define GIFILT__COLD
#endif

/* Where a message goes, and the name of the function that failed. If log is NULL, nothing is written. */
typedef struct gifilt__logger {
    void (*log)(void *user, const char *message);
    void *user;
    const char *function;
} gifilt__logger;

typedef struct gifilt__message { char text[256]; size_t used; } gifilt__message;

/* Appends a text; what does not fit is cut off. */
static inline GIFILT__COLD void gifilt__message_text(gifilt__message *m, const char *s)
{
    while (*s && m->used + 1 < sizeof m->text) m->text[m->used++] = *s++;
    m->text[m->used] = 0;
}

static inline GIFILT__COLD void gifilt__message_count(gifilt__message *m, uint64_t value)
{
    char digits[24];
    size_t at = sizeof digits - 1;
    digits[at] = 0;
    do digits[--at] = (char)('0' + (int)(value % 10));
    while ((value /= 10) != 0);
    gifilt__message_text(m, digits + at);
}

/* Writes six significant digits without the zeros at their end. Returns how many digits are left and writes
   *exponent, the power of ten of the first one. value is finite and above 0. */
static inline GIFILT__COLD int gifilt__message_digits(double value, char digits[8], int *exponent)
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
static inline GIFILT__COLD void gifilt__message_number(gifilt__message *m, double value)
{
    char digits[8], first[2] = { 0, 0 };
    int exponent, count, i;

    if (value != value) {
        gifilt__message_text(m, "not a number");
        return;
    }
    if (value < 0.0) gifilt__message_text(m, "-");
    if (value < 0.0) value = -value;
    if (!(value > 0.0) || value > 1.7976931348623157e308) {
        gifilt__message_text(m, value > 0.0 ? "infinity" : "0");
        return;
    }
    if (value < 9007199254740992.0 && value - (double)(uint64_t)value <= 0.0) {
        gifilt__message_count(m, (uint64_t)value);
        return;
    }
    count = gifilt__message_digits(value, digits, &exponent);
    first[0] = digits[0];
    if (exponent < -4 || exponent > 9) {
        gifilt__message_text(m, first);
        if (count > 1) gifilt__message_text(m, ".");
        gifilt__message_text(m, digits + 1);
        gifilt__message_text(m, exponent < 0 ? "e-" : "e");
        gifilt__message_count(m, (uint64_t)(exponent < 0 ? -exponent : exponent));
        return;
    }
    if (exponent < 0) gifilt__message_text(m, "0.");
    for (i = exponent; i < -1; i++) gifilt__message_text(m, "0");
    for (i = 0; i < count; i++) {
        if (exponent >= 0 && i == exponent + 1) gifilt__message_text(m, ".");
        first[0] = digits[i];
        gifilt__message_text(m, first);
    }
    for (i = count; i <= exponent; i++) gifilt__message_text(m, "0");
}

/* Begins a line: "FUNCTION: FIELD". */
static inline GIFILT__COLD void gifilt__message_begin(gifilt__message *m,
                                          const gifilt__logger *logger, const char *field)
{
    m->used = 0;
    gifilt__message_text(m, logger->function);
    gifilt__message_text(m, ": ");
    gifilt__message_text(m, field);
}

/* Logs "FUNCTION: FIELD TEXT", as in "cohsm_build: mesh.positions is NULL". */
static inline GIFILT__COLD void gifilt__log_text(const gifilt__logger *logger, const char *field, const char *text)
{
    gifilt__message m;
    if (!logger->log) return;
    gifilt__message_begin(&m, logger, field);
    gifilt__message_text(&m, " ");
    gifilt__message_text(&m, text);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: FIELD is VALUE; it must be WANTED", as in "cohsm_build: desc.map_side is 3; it must be 0 or
   4..1024". */
static inline GIFILT__COLD void gifilt__log_value(const gifilt__logger *logger, const char *field, double value,
                                      const char *wanted)
{
    gifilt__message m;
    if (!logger->log) return;
    gifilt__message_begin(&m, logger, field);
    gifilt__message_text(&m, " is ");
    gifilt__message_number(&m, value);
    gifilt__message_text(&m, "; it must be ");
    gifilt__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: ARRAY[INDEX] WHAT VALUE; it must be WANTED", as in "rsm_gather: normals[17] has the length
   0.5; it must be 1 (0.97..1.03), or 0". */
static inline GIFILT__COLD void gifilt__log_element(const gifilt__logger *logger, const char *array, uint64_t index,
                                        const char *what, double value, const char *wanted)
{
    gifilt__message m;
    if (!logger->log) return;
    gifilt__message_begin(&m, logger, array);
    gifilt__message_text(&m, "[");
    gifilt__message_count(&m, index);
    gifilt__message_text(&m, "] ");
    gifilt__message_text(&m, what);
    gifilt__message_text(&m, " ");
    gifilt__message_number(&m, value);
    gifilt__message_text(&m, "; it must be ");
    gifilt__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* ==== src/gifilter/arguments.h ==== */

/* ---- arguments: results, strides, systems, points ---- */

#define GIFILT__MAX_FLOAT 3.40282347e38f
#define GIFILT__MAX_LIGHT 1e30f     /* more counts as 0, so that sums of neighbours stay finite */
#define GIFILT__FAR 3.0e38f

enum {
    GIFILT__SPAN = 64,          /* pixels of a row that are taken at once */
    GIFILT__WIDE = 16           /* lanes of the widest vectors */
};

GIFILT_DEF const char *gifilt_result_text(gifilt_result result)
{
    switch (result) {
#define GIFILT__TEXT(name, text) case name: return text;
    GIFILT_RESULTS(GIFILT__TEXT)
#undef GIFILT__TEXT
    case GIFILT_RESULT_COUNT: break;
    }
    return "unknown result";
}

static inline size_t gifilt__stride(size_t stride, size_t standard) { return stride ? stride : standard; }

/* Returns where a call says why it fails. system may be NULL. */
static inline gifilt__logger gifilt__logger_of(const gifilt_system *system, const char *function)
{
    gifilt__logger log;
    log.log = system ? system->log : NULL;
    log.user = system ? system->user : NULL;
    log.function = function;
    return log;
}

/* Logs "FIELD TEXT" and returns the result, for a call that returns it too. */
static inline gifilt_result gifilt__refuse(const gifilt__logger *log, gifilt_result result, const char *field,
                                           const char *text)
{
    gifilt__log_text(log, field, text);
    return result;
}

/* Returns 1 if a value lies within low..high; otherwise, also if it is not a number, logs it and returns 0.
   */
static inline int gifilt__check_range(const gifilt__logger *log, const char *field, double value, double low,
                                      double high, const char *wanted)
{
    if (value >= low && value <= high) return 1;
    gifilt__log_value(log, field, value, wanted);
    return 0;
}

static inline int gifilt__system_valid(const gifilt__logger *log, const gifilt_system *s)
{
    if (gifilt__allocator_valid(s->allocator.alloc_fn, s->allocator.free_fn)) return 1;
    gifilt__log_text(log, "desc.system.allocator", "has one function of two");
    return 0;
}

static inline gifilt__allocator gifilt__allocator_of(const gifilt_system *s)
{
    return gifilt__allocator_make(s->allocator.alloc_fn, s->allocator.free_fn, s->allocator.user);
}

static inline void gifilt__run(const gifilt_system *s, size_t count, gifilt_task task, void *context)
{
    size_t i;
    if (s->parallel_for) s->parallel_for(s->user, count, task, context);
    else
        for (i = 0; i < count; i++) task(context, i);
}

/* Returns 1 if points can be used, whatever their count; else logs why and returns 0. */
static inline int gifilt__points_valid(const gifilt__logger *log, const gifilt_points *p)
{
    if (!p || !p->positions || !p->normals) {
        gifilt__log_text(log,
                         !p             ? "points"
                         : p->positions ? "points.normals"
                                        : "points.positions",
                         "is NULL");
        return 0;
    }
    if (!gifilt__stride_valid(p->position_stride, 12)) {
        gifilt__log_value(log, "points.position_stride", (double)p->position_stride,
                          "0 or a multiple of 4, at least 12");
        return 0;
    }
    if (gifilt__stride_valid(p->normal_stride, 12)) return 1;
    gifilt__log_value(log, "points.normal_stride", (double)p->normal_stride,
                      "0 or a multiple of 4, at least 12");
    return 0;
}

/* ==== src/gifilter/picture.h ==== */

/* ---- picture: rows of floats, and which neighbours show the same surface ---- */

/* Each row of the picture is GIFILT__PLANES rows of floats, so that neighbours are compared in vectors:
   position, normal, colour, frames. A pixel that shows nothing has normal and frames 0. So has a margin right
   of each row, which is as wide as the longest step and serves the row after as its left margin: no kernel
   has to ask where the picture ends. */
enum { GIFILT__RGB = 6, GIFILT__FRAMES = 9, GIFILT__PLANES = 10, GIFILT__MARGIN = 32, GIFILT__TASK_ROWS = 8 };

struct gifilt_filter {
    gifilt_system system;
    float     *memory[2];
    float     *history;            /* the last frame, in one of them */
    float     *next;               /* this frame, in the other */
    size_t     spacing;            /* floats from one row of floats to the next */
    uint32_t   width, height;
    uint8_t   *wrong_rows;         /* not 0: the row has a normal that is not unit */
    int        has_matrix;
    float      matrix[16];         /* of the frame in history */
};

struct gifilt__filter_run;
typedef void (*gifilt__filter_row)(const struct gifilt__filter_run *r, size_t y);

typedef struct gifilt__filter_run {
    gifilt_filter            *filter;
    const gifilt_frame *frame;
    const gifilt_points      *points;
    const float           *in;     /* irradiance; then rows of three rows, in_row floats apart */
    float                 *out;    /* the same, or with packed three floats a pixel */
    size_t                 in_row, out_row;
    int                    packed, recalls;
    uint32_t               step, history;
    float                  limits[3];      /* cosine, 1 / (1 - cosine), slope^2 */
    gifilt__filter_row        accumulate, smooth, row;        /* row: one of them, which tasks are for */
} gifilt__filter_run;

/* Asks for planes of a row that is read soon: more rows are read side by side than processors foresee. */
GIFILT__INLINE void gifilt__fetch_ahead(const float *p, size_t spacing, size_t planes)
{
    size_t c;
    for (c = 0; c < planes; c++) GIFILT__PREFETCH(p + c * spacing);
}

/* ---- chunk: some pixels of a row ---- */

/* What this frame sees of a chunk of pixels, and what the last one knew of them. */
typedef struct gifilt__chunk {
    float now[GIFILT__PLANES][GIFILT__SPAN];
    float given[9][GIFILT__SPAN + 1];   /* places, normals, light; also the place of the pixel after: after
                                           the last one of a row that of the pixel before */
    float size2[GIFILT__SPAN];          /* square of the distance within which a pixel of the last frame may
                                           show the same surface */
    float x[GIFILT__SPAN], y[GIFILT__SPAN];    /* where they were in the last frame's picture */
    float i[GIFILT__SPAN], j[GIFILT__SPAN];    /* whole numbers: the place lies between pixels i, j and i + 1,
                                                  j + 1 */
    float u[GIFILT__SPAN], v[GIFILT__SPAN];    /* how far between them, 0..1 */
    float there[GIFILT__SPAN];          /* 1 if the pixel shows something; after the projection, if the last
                                           frame may have seen it; otherwise 0 */
    float sums[5][GIFILT__SPAN];        /* over pixels of the last frame: colour, frames, weights */
} gifilt__chunk;

/* How many floats away a neighbour's shape and colour are, and its weight in the kernel. */
typedef struct gifilt__tap { ptrdiff_t shape, rgb; float weight; } gifilt__tap;

/* Lists the neighbours that row y's pixels have in the picture, up to eight, and returns how many they are.
   */
static inline size_t gifilt__taps(const gifilt__filter_run *r, size_t y, gifilt__tap taps[8])
{
    ptrdiff_t i, j, row = (ptrdiff_t)y, step = (ptrdiff_t)r->step;
    size_t count = 0;
    for (j = -step; j <= step; j += step)
        for (i = -step; i <= step; i += step) {
            if ((i == 0 && j == 0) || row + j < 0 || row + j >= (ptrdiff_t)r->filter->height) continue;
            taps[count].shape = j * (ptrdiff_t)(GIFILT__PLANES * r->filter->spacing) + i;
            taps[count].rgb = j * (ptrdiff_t)r->in_row + i;
            taps[count++].weight = i && j ? 1.0f : 2.0f;
        }
    return count;
}

/* Copies count pixels into a chunk; strides are in floats. */
GIFILT__INLINE void gifilt__chunk_read(gifilt__chunk *k, const float *p, size_t ps, const float *n, size_t ns,
                                 const float *light, size_t count)
{
    size_t l;
    for (l = 0; l < count; l++) {
        k->given[0][l] = p[ps * l];
        k->given[1][l] = p[ps * l + 1];
        k->given[2][l] = p[ps * l + 2];
    }
    for (l = 0; l < count; l++) {
        k->given[3][l] = n[ns * l];
        k->given[4][l] = n[ns * l + 1];
        k->given[5][l] = n[ns * l + 2];
    }
    for (l = 0; l < count; l++) {
        k->given[6][l] = light[3 * l];
        k->given[7][l] = light[3 * l + 1];
        k->given[8][l] = light[3 * l + 2];
    }
}

/* ==== src/gifilter/kernels_begin.h ==== */

/* ---- kernels: one text, compiled for every instruction set ---- */

static const float gifilt__numbers[GIFILT__WIDE] = { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15 };

/* Names that every instruction set has of its own, see unit simd. */
#define gifilt__shapes GIFILT__NAME_IN_SET(gifilt__shapes, GIFILT__SET)
#define gifilt__shapes_load GIFILT__NAME_IN_SET(gifilt__shapes_load, GIFILT__SET)
#define gifilt__alike GIFILT__NAME_IN_SET(gifilt__alike, GIFILT__SET)
#define gifilt__at_most GIFILT__NAME_IN_SET(gifilt__at_most, GIFILT__SET)
#define gifilt__at_most3 GIFILT__NAME_IN_SET(gifilt__at_most3, GIFILT__SET)
#define gifilt__not_zero GIFILT__NAME_IN_SET(gifilt__not_zero, GIFILT__SET)
#define gifilt__are_there GIFILT__NAME_IN_SET(gifilt__are_there, GIFILT__SET)
#define gifilt__set_there GIFILT__NAME_IN_SET(gifilt__set_there, GIFILT__SET)
#define gifilt__chunk_set GIFILT__NAME_IN_SET(gifilt__chunk_set, GIFILT__SET)
#define gifilt__chunk_load GIFILT__NAME_IN_SET(gifilt__chunk_load, GIFILT__SET)
#define gifilt__chunk_wrong GIFILT__NAME_IN_SET(gifilt__chunk_wrong, GIFILT__SET)
#define gifilt__row_times GIFILT__NAME_IN_SET(gifilt__row_times, GIFILT__SET)
#define gifilt__chunk_project GIFILT__NAME_IN_SET(gifilt__chunk_project, GIFILT__SET)
#define gifilt__near_picture GIFILT__NAME_IN_SET(gifilt__near_picture, GIFILT__SET)
#define gifilt__place_axis GIFILT__NAME_IN_SET(gifilt__place_axis, GIFILT__SET)
#define gifilt__chunk_place GIFILT__NAME_IN_SET(gifilt__chunk_place, GIFILT__SET)
#define gifilt__add_to GIFILT__NAME_IN_SET(gifilt__add_to, GIFILT__SET)
#define gifilt__chunk_recall GIFILT__NAME_IN_SET(gifilt__chunk_recall, GIFILT__SET)
#define gifilt__range_of GIFILT__NAME_IN_SET(gifilt__range_of, GIFILT__SET)
#define gifilt__chunk_range GIFILT__NAME_IN_SET(gifilt__chunk_range, GIFILT__SET)
#define gifilt__share GIFILT__NAME_IN_SET(gifilt__share, GIFILT__SET)
#define gifilt__past_runs GIFILT__NAME_IN_SET(gifilt__past_runs, GIFILT__SET)
#define gifilt__past_each GIFILT__NAME_IN_SET(gifilt__past_each, GIFILT__SET)
#define gifilt__chunk_past GIFILT__NAME_IN_SET(gifilt__chunk_past, GIFILT__SET)
#define gifilt__chunk_blend GIFILT__NAME_IN_SET(gifilt__chunk_blend, GIFILT__SET)
#define gifilt__accumulate GIFILT__NAME_IN_SET(gifilt__accumulate, GIFILT__SET)
#define gifilt__means GIFILT__NAME_IN_SET(gifilt__means, GIFILT__SET)
#define gifilt__despeckled GIFILT__NAME_IN_SET(gifilt__despeckled, GIFILT__SET)
#define gifilt__add_tap GIFILT__NAME_IN_SET(gifilt__add_tap, GIFILT__SET)
#define gifilt__smooth_some GIFILT__NAME_IN_SET(gifilt__smooth_some, GIFILT__SET)
#define gifilt__smooth GIFILT__NAME_IN_SET(gifilt__smooth, GIFILT__SET)

#define GIFILT__SET plain
#define GIFILT__WIDTH GIFILT__SIMD_WIDTH
#define GIFILT__LANE_COUNT 8

#endif /* !GIFILTER_IMPLEMENTED */

#ifdef GIFILT__SET
#if GIFILT_VERSION != 10000 /* this file's: another one that includes it as GIFILT_FILE has its own */
#error "gifilter.h: the file that GIFILT_FILE names is of another version than the one that includes it"
#endif

/* ==== src/shared/simd_begin.h ==== */

/* unit simd_begin, needs simd: what the kernels of one instruction set are compiled with */

#undef GIFILT__KERNEL
#undef GIFILT__IN_KERNEL
#undef GIFILT__IN_LARGE_KERNEL
#undef GIFILT__INTEL
#undef GIFILT__EACH

#if GIFILT__WIDTH == 16
#define GIFILT__KERNEL GIFILT__TARGET_AVX512
#elif GIFILT__WIDTH == 8
#define GIFILT__KERNEL GIFILT__TARGET_AVX2
#else
#define GIFILT__KERNEL
#endif

#if GIFILT__WIDTH == 16
#define GIFILT__INTEL(name) _mm512_##name
#elif GIFILT__WIDTH == 8
#define GIFILT__INTEL(name) _mm256_##name
#else
#define GIFILT__INTEL(name) _mm_##name
#endif

/* GIFILT__IN_LARGE_KERNEL stands after `static`, before a function that a kernel calls dozens of times. Such a
   function is not inlined without optimisation, nor with gcc's sanitizers, which take minutes to build large
   functions. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define GIFILT__IN_KERNEL __attribute__((always_inline)) GIFILT__KERNEL
#else
#define GIFILT__IN_KERNEL GIFILT__KERNEL
#endif
#if defined(__GNUC__) && !defined(__TINYC__) && (!defined(__OPTIMIZE__) || defined(__SANITIZE_ADDRESS__))
#define GIFILT__IN_LARGE_KERNEL __attribute__((noinline)) GIFILT__KERNEL
#else
#define GIFILT__IN_LARGE_KERNEL inline GIFILT__IN_KERNEL
#endif

/* GIFILT__EACH executes statements for every piece of GIFILT__WIDTH lanes. The number of the piece is a constant in
   them, so that compilers keep pieces in registers. */
#if GIFILT__WIDTH > 1 && GIFILT__LANE_COUNT == GIFILT__WIDTH
#define GIFILT__EACH(...) { enum { piece = 0 }; __VA_ARGS__; }
#elif GIFILT__WIDTH > 1 && GIFILT__LANE_COUNT == 2 * GIFILT__WIDTH
#define GIFILT__EACH(...) { enum { piece = 0 }; __VA_ARGS__; } { enum { piece = 1 }; __VA_ARGS__; }
#elif GIFILT__WIDTH > 1 && GIFILT__LANE_COUNT == 4 * GIFILT__WIDTH
#define GIFILT__EACH(...) \
    { enum { piece = 0 }; __VA_ARGS__; } { enum { piece = 1 }; __VA_ARGS__; } \
    { enum { piece = 2 }; __VA_ARGS__; } { enum { piece = 3 }; __VA_ARGS__; }
#else
#define GIFILT__EACH(...) \
    { int piece; for (piece = 0; piece < GIFILT__LANE_COUNT / GIFILT__WIDTH; piece++) { __VA_ARGS__; } }
#endif

/* ==== src/shared/simd_x86.h ==== */

/* unit simd_x86, needs simd_begin: lanes of SSE2, AVX2 and AVX-512 */

#if GIFILT__SIMD_X86 || GIFILT__WIDTH > 4

#if GIFILT__WIDTH == 16
typedef struct gifilt__lanes { __m512 v[GIFILT__LANE_COUNT / 16]; } gifilt__lanes;
typedef struct gifilt__lane_ints { __m512i v[GIFILT__LANE_COUNT / 16]; } gifilt__lane_ints;
typedef struct gifilt__lane_mask { __mmask16 v[GIFILT__LANE_COUNT / 16]; } gifilt__lane_mask;
#elif GIFILT__WIDTH == 8
typedef struct gifilt__lanes { __m256 v[GIFILT__LANE_COUNT / 8]; } gifilt__lanes;
typedef struct gifilt__lane_ints { __m256i v[GIFILT__LANE_COUNT / 8]; } gifilt__lane_ints;
typedef struct gifilt__lane_mask { __m256 v[GIFILT__LANE_COUNT / 8]; } gifilt__lane_mask;
#else
typedef struct gifilt__lanes { __m128 v[GIFILT__LANE_COUNT / 4]; } gifilt__lanes;
typedef struct gifilt__lane_ints { __m128i v[GIFILT__LANE_COUNT / 4]; } gifilt__lane_ints;
typedef struct gifilt__lane_mask { __m128 v[GIFILT__LANE_COUNT / 4]; } gifilt__lane_mask;
#endif

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_load(const float *from)
{
    gifilt__lanes a;
    GIFILT__EACH(a.v[piece] = GIFILT__INTEL(loadu_ps)(from + piece * GIFILT__WIDTH))
    return a;
}

static inline GIFILT__IN_KERNEL void gifilt__lanes_store(float *to, gifilt__lanes a)
{
    GIFILT__EACH(GIFILT__INTEL(storeu_ps)(to + piece * GIFILT__WIDTH, a.v[piece]))
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_all(float x)
{
    gifilt__lanes a;
    GIFILT__EACH(a.v[piece] = GIFILT__INTEL(set1_ps)(x))
    return a;
}

/* Comparisons with what is not a number are false, but for differ, which is true. */
static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__lanes_greater(gifilt__lanes a, gifilt__lanes b)
{
    gifilt__lane_mask m;
#if GIFILT__WIDTH == 16
    GIFILT__EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_GT_OQ))
#elif GIFILT__WIDTH == 8
    GIFILT__EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_GT_OQ))
#else
    GIFILT__EACH(m.v[piece] = _mm_cmpgt_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__lanes_at_least(gifilt__lanes a, gifilt__lanes b)
{
    gifilt__lane_mask m;
#if GIFILT__WIDTH == 16
    GIFILT__EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_GE_OQ))
#elif GIFILT__WIDTH == 8
    GIFILT__EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_GE_OQ))
#else
    GIFILT__EACH(m.v[piece] = _mm_cmpge_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__lanes_differ(gifilt__lanes a, gifilt__lanes b)
{
    gifilt__lane_mask m;
#if GIFILT__WIDTH == 16
    GIFILT__EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_NEQ_UQ))
#elif GIFILT__WIDTH == 8
    GIFILT__EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_NEQ_UQ))
#else
    GIFILT__EACH(m.v[piece] = _mm_cmpneq_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

/* Returns m ? a : b in each lane. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_select(gifilt__lane_mask m, gifilt__lanes a,
                                                 gifilt__lanes b)
{
#if GIFILT__WIDTH == 16
    GIFILT__EACH(a.v[piece] = _mm512_mask_mov_ps(b.v[piece], m.v[piece], a.v[piece]))
#elif GIFILT__WIDTH == 8
    GIFILT__EACH(a.v[piece] = _mm256_blendv_ps(b.v[piece], a.v[piece], m.v[piece]))
#else
    GIFILT__EACH(a.v[piece] = _mm_or_ps(_mm_and_ps(m.v[piece], a.v[piece]), _mm_andnot_ps(m.v[piece], b.v[piece])))
#endif
    return a;
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_add(gifilt__lanes a, gifilt__lanes b)
{
    GIFILT__EACH(a.v[piece] = GIFILT__INTEL(add_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_sub(gifilt__lanes a, gifilt__lanes b)
{
    GIFILT__EACH(a.v[piece] = GIFILT__INTEL(sub_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_mul(gifilt__lanes a, gifilt__lanes b)
{
    GIFILT__EACH(a.v[piece] = GIFILT__INTEL(mul_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_div(gifilt__lanes a, gifilt__lanes b)
{
    GIFILT__EACH(a.v[piece] = GIFILT__INTEL(div_ps)(a.v[piece], b.v[piece]))
    return a;
}

/* Returns a > b ? a : b, so that b is the answer if one is not a number. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_max(gifilt__lanes a, gifilt__lanes b)
{
#if GIFILT__WIDTH == 16                           /* gcc 12 warns of what max without a mask calls */
    GIFILT__EACH(a.v[piece] = _mm512_maskz_max_ps((__mmask16)0xffff, a.v[piece], b.v[piece]))
#else
    GIFILT__EACH(a.v[piece] = GIFILT__INTEL(max_ps)(a.v[piece], b.v[piece]))
#endif
    return a;
}

/* Returns a < b ? a : b. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_min(gifilt__lanes a, gifilt__lanes b)
{
#if GIFILT__WIDTH == 16                           /* gcc 12 warns of what min without a mask calls */
    GIFILT__EACH(a.v[piece] = _mm512_maskz_min_ps((__mmask16)0xffff, a.v[piece], b.v[piece]))
#else
    GIFILT__EACH(a.v[piece] = GIFILT__INTEL(min_ps)(a.v[piece], b.v[piece]))
#endif
    return a;
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_abs(gifilt__lanes a)
{
    GIFILT__EACH(a.v[piece] = GIFILT__INTEL(andnot_ps)(GIFILT__INTEL(set1_ps)(-0.0f), a.v[piece]))
    return a;
}

/* Returns m ? a : 0. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_keep(gifilt__lane_mask m, gifilt__lanes a)
{
#if GIFILT__WIDTH == 16
    GIFILT__EACH(a.v[piece] = _mm512_maskz_mov_ps(m.v[piece], a.v[piece]))
#else
    GIFILT__EACH(a.v[piece] = GIFILT__INTEL(and_ps)(m.v[piece], a.v[piece]))
#endif
    return a;
}

/* Rounds towards 0. An int32_t must be able to hold each float. */
static inline GIFILT__IN_KERNEL gifilt__lane_ints gifilt__lanes_truncate(gifilt__lanes a)
{
    gifilt__lane_ints k;
#if GIFILT__WIDTH == 16
    GIFILT__EACH(k.v[piece] = _mm512_maskz_cvttps_epi32((__mmask16)0xffff, a.v[piece]))
#else
    GIFILT__EACH(k.v[piece] = GIFILT__INTEL(cvttps_epi32)(a.v[piece]))
#endif
    return k;
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_of_ints(gifilt__lane_ints k)
{
    gifilt__lanes a;
#if GIFILT__WIDTH == 16
    GIFILT__EACH(a.v[piece] = _mm512_maskz_cvtepi32_ps((__mmask16)0xffff, k.v[piece]))
#else
    GIFILT__EACH(a.v[piece] = GIFILT__INTEL(cvtepi32_ps)(k.v[piece]))
#endif
    return a;
}

static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__mask_and(gifilt__lane_mask m, gifilt__lane_mask n)
{
#if GIFILT__WIDTH == 16
    GIFILT__EACH(m.v[piece] = (__mmask16)(m.v[piece] & n.v[piece]))
#else
    GIFILT__EACH(m.v[piece] = GIFILT__INTEL(and_ps)(m.v[piece], n.v[piece]))
#endif
    return m;
}

static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__mask_or(gifilt__lane_mask m, gifilt__lane_mask n)
{
#if GIFILT__WIDTH == 16
    GIFILT__EACH(m.v[piece] = (__mmask16)(m.v[piece] | n.v[piece]))
#else
    GIFILT__EACH(m.v[piece] = GIFILT__INTEL(or_ps)(m.v[piece], n.v[piece]))
#endif
    return m;
}

static inline GIFILT__IN_KERNEL int gifilt__mask_any(gifilt__lane_mask m)
{
    int any = 0;
#if GIFILT__WIDTH == 16
    GIFILT__EACH(any |= m.v[piece])
#else
    GIFILT__EACH(any |= GIFILT__INTEL(movemask_ps)(m.v[piece]))
#endif
    return any != 0;
}

#endif

/* ==== src/shared/simd_plain.h ==== */

/* unit simd_plain, needs simd_begin: lanes of NEON, WebAssembly and others, or floats one by one */

#if !GIFILT__SIMD_X86 && GIFILT__WIDTH <= 4

#if GIFILT__SIMD_VECTORS
typedef float gifilt__piece __attribute__((vector_size(16)));
typedef int32_t gifilt__piece_ints __attribute__((vector_size(16)));
typedef uint32_t gifilt__piece_words __attribute__((vector_size(16)));
#else
typedef float gifilt__piece;
typedef int32_t gifilt__piece_ints;
typedef uint32_t gifilt__piece_words;
#endif
typedef struct gifilt__lanes { gifilt__piece v[GIFILT__LANE_COUNT / GIFILT__WIDTH]; } gifilt__lanes;
typedef struct gifilt__lane_ints { gifilt__piece_ints v[GIFILT__LANE_COUNT / GIFILT__WIDTH]; } gifilt__lane_ints;
/* Lanes of 0 or -1. */
typedef struct gifilt__lane_mask { gifilt__piece_ints v[GIFILT__LANE_COUNT / GIFILT__WIDTH]; } gifilt__lane_mask;

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_load(const float *from)
{
    gifilt__lanes a;
    GIFILT__EACH(memcpy(&a.v[piece], from + piece * GIFILT__WIDTH, sizeof a.v[piece]))
    return a;
}

static inline GIFILT__IN_KERNEL void gifilt__lanes_store(float *to, gifilt__lanes a)
{
    GIFILT__EACH(memcpy(to + piece * GIFILT__WIDTH, &a.v[piece], sizeof a.v[piece]))
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_all(float x)
{
    gifilt__lanes a;
#if GIFILT__SIMD_VECTORS
    const gifilt__piece all = { x, x, x, x };
    GIFILT__EACH(a.v[piece] = all)
#else
    GIFILT__EACH(a.v[piece] = x)
#endif
    return a;
}

/* Comparisons with what is not a number are false, but for differ, which is true. */
static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__lanes_greater(gifilt__lanes a, gifilt__lanes b)
{
    gifilt__lane_mask m;
#if GIFILT__SIMD_VECTORS
    GIFILT__EACH(m.v[piece] = a.v[piece] > b.v[piece])
#else
    GIFILT__EACH(m.v[piece] = -(a.v[piece] > b.v[piece]))
#endif
    return m;
}

static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__lanes_at_least(gifilt__lanes a, gifilt__lanes b)
{
    gifilt__lane_mask m;
#if GIFILT__SIMD_VECTORS
    GIFILT__EACH(m.v[piece] = a.v[piece] >= b.v[piece])
#else
    GIFILT__EACH(m.v[piece] = -(a.v[piece] >= b.v[piece]))
#endif
    return m;
}

static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__lanes_differ(gifilt__lanes a, gifilt__lanes b)
{
    gifilt__lane_mask m;
#if GIFILT__SIMD_VECTORS
    GIFILT__EACH(m.v[piece] = a.v[piece] != b.v[piece])
#else
    GIFILT__EACH(m.v[piece] = -(a.v[piece] != b.v[piece]))
#endif
    return m;
}

/* Returns m ? a : b in each lane. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_select(gifilt__lane_mask m, gifilt__lanes a,
                                                 gifilt__lanes b)
{
#if GIFILT__SIMD_VECTORS
    GIFILT__EACH(a.v[piece] = (gifilt__piece)((m.v[piece] & (gifilt__piece_ints)a.v[piece]) |
                                  (~m.v[piece] & (gifilt__piece_ints)b.v[piece])))
#else
    GIFILT__EACH(a.v[piece] = m.v[piece] ? a.v[piece] : b.v[piece])
#endif
    return a;
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_add(gifilt__lanes a, gifilt__lanes b)
{
    GIFILT__EACH(a.v[piece] = a.v[piece] + b.v[piece])
    return a;
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_sub(gifilt__lanes a, gifilt__lanes b)
{
    GIFILT__EACH(a.v[piece] = a.v[piece] - b.v[piece])
    return a;
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_mul(gifilt__lanes a, gifilt__lanes b)
{
    GIFILT__EACH(a.v[piece] = a.v[piece] * b.v[piece])
    return a;
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_div(gifilt__lanes a, gifilt__lanes b)
{
    GIFILT__EACH(a.v[piece] = a.v[piece] / b.v[piece])
    return a;
}

/* Returns a > b ? a : b, so that b is the answer if one is not a number. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_max(gifilt__lanes a, gifilt__lanes b)
{
    return gifilt__lanes_select(gifilt__lanes_greater(a, b), a, b);
}

/* Returns a < b ? a : b. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_min(gifilt__lanes a, gifilt__lanes b)
{
    return gifilt__lanes_select(gifilt__lanes_greater(b, a), a, b);
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_abs(gifilt__lanes a)
{
#if GIFILT__SIMD_VECTORS
    const int32_t b = 0x7fffffff;
    const gifilt__piece_ints bits = { b, b, b, b };
    GIFILT__EACH(a.v[piece] = (gifilt__piece)((gifilt__piece_ints)a.v[piece] & bits))
#else
    GIFILT__EACH(a.v[piece] = fabsf(a.v[piece]))
#endif
    return a;
}

/* Returns m ? a : 0. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_keep(gifilt__lane_mask m, gifilt__lanes a)
{
#if GIFILT__SIMD_VECTORS
    GIFILT__EACH(a.v[piece] = (gifilt__piece)(m.v[piece] & (gifilt__piece_ints)a.v[piece]))
#else
    GIFILT__EACH(a.v[piece] = m.v[piece] ? a.v[piece] : 0.0f)
#endif
    return a;
}

/* Rounds towards 0. An int32_t must be able to hold each float. */
static inline GIFILT__IN_KERNEL gifilt__lane_ints gifilt__lanes_truncate(gifilt__lanes a)
{
    gifilt__lane_ints k;
#if GIFILT__SIMD_VECTORS
    GIFILT__EACH(k.v[piece] = __builtin_convertvector(a.v[piece], gifilt__piece_ints))
#else
    GIFILT__EACH(k.v[piece] = (int32_t)a.v[piece])
#endif
    return k;
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes_of_ints(gifilt__lane_ints k)
{
    gifilt__lanes a;
#if GIFILT__SIMD_VECTORS           /* + 0: of 0 that was truncated from -0.5, gcc 12 makes -0 for NEON */
    GIFILT__EACH(a.v[piece] = __builtin_convertvector(k.v[piece], gifilt__piece) + 0.0f)
#else
    GIFILT__EACH(a.v[piece] = (float)k.v[piece])
#endif
    return a;
}

static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__mask_and(gifilt__lane_mask m, gifilt__lane_mask n)
{
    GIFILT__EACH(m.v[piece] = m.v[piece] & n.v[piece])
    return m;
}

static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__mask_or(gifilt__lane_mask m, gifilt__lane_mask n)
{
    GIFILT__EACH(m.v[piece] = m.v[piece] | n.v[piece])
    return m;
}

static inline GIFILT__IN_KERNEL int gifilt__mask_any(gifilt__lane_mask m)
{
    int any = 0;
#if GIFILT__SIMD_VECTORS
    GIFILT__EACH(any |= m.v[piece][0] | m.v[piece][1] | m.v[piece][2] | m.v[piece][3])
#else
    GIFILT__EACH(any |= m.v[piece])
#endif
    return any != 0;
}

#endif

/* ==== src/shared/simd_lanes3.h ==== */

/* unit simd_lanes3, needs simd_begin: vectors of three in lanes */

typedef struct gifilt__lanes3 { gifilt__lanes x, y, z; } gifilt__lanes3;

static inline GIFILT__IN_KERNEL gifilt__lanes3 gifilt__lanes3_load(const float *x, const float *y, const float *z)
{
    gifilt__lanes3 a;
    a.x = gifilt__lanes_load(x);
    a.y = gifilt__lanes_load(y);
    a.z = gifilt__lanes_load(z);
    return a;
}

static inline GIFILT__IN_KERNEL gifilt__lanes3 gifilt__lanes3_all(float x, float y, float z)
{
    gifilt__lanes3 a;
    a.x = gifilt__lanes_all(x);
    a.y = gifilt__lanes_all(y);
    a.z = gifilt__lanes_all(z);
    return a;
}

static inline GIFILT__IN_KERNEL gifilt__lanes3 gifilt__lanes3_sub(gifilt__lanes3 a, gifilt__lanes3 b)
{
    a.x = gifilt__lanes_sub(a.x, b.x);
    a.y = gifilt__lanes_sub(a.y, b.y);
    a.z = gifilt__lanes_sub(a.z, b.z);
    return a;
}

static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__lanes3_dot(gifilt__lanes3 a, gifilt__lanes3 b)
{
    return gifilt__lanes_add(gifilt__lanes_add(gifilt__lanes_mul(a.x, b.x), gifilt__lanes_mul(a.y, b.y)),
                       gifilt__lanes_mul(a.z, b.z));
}

/* Stores x, y, z of the first lane, then those of the next, and so on. */
static inline GIFILT__IN_KERNEL void gifilt__lanes3_store_packed(float *xyz, gifilt__lanes3 a)
{
#if GIFILT__WIDTH == 16
    static const int32_t from[16] = { 0, 16, 0, 1, 17, 0, 2, 18, 0, 3, 19, 0, 4, 20, 0, 5 };
    static const int32_t third[16] = { 0, 1, 16, 3, 4, 17, 6, 7, 18, 9, 10, 19, 12, 13, 20, 15 };
    static const int32_t from1[16] = { 21, 0, 6, 22, 0, 7, 23, 0, 8, 24, 0, 9, 25, 0, 10, 26 };
    static const int32_t third1[16] = { 0, 21, 2, 3, 22, 5, 6, 23, 8, 9, 24, 11, 12, 25, 14, 15 };
    static const int32_t from2[16] = { 0, 11, 27, 0, 12, 28, 0, 13, 29, 0, 14, 30, 0, 15, 31, 0 };
    static const int32_t third2[16] = { 26, 1, 2, 27, 4, 5, 28, 7, 8, 29, 10, 11, 30, 13, 14, 31 };
    GIFILT__EACH(
        const __m512 p = _mm512_permutex2var_ps(a.x.v[piece], _mm512_loadu_si512(from), a.y.v[piece]);
        const __m512 q = _mm512_permutex2var_ps(a.x.v[piece], _mm512_loadu_si512(from1), a.y.v[piece]);
        const __m512 r = _mm512_permutex2var_ps(a.x.v[piece], _mm512_loadu_si512(from2), a.y.v[piece]);
        float *to = xyz + 3 * GIFILT__WIDTH * piece;
        _mm512_storeu_ps(to, _mm512_permutex2var_ps(p, _mm512_loadu_si512(third), a.z.v[piece]));
        _mm512_storeu_ps(to + 16, _mm512_permutex2var_ps(q, _mm512_loadu_si512(third1), a.z.v[piece]));
        _mm512_storeu_ps(to + 32, _mm512_permutex2var_ps(r, _mm512_loadu_si512(third2), a.z.v[piece])))
#else
    float x[GIFILT__LANE_COUNT], y[GIFILT__LANE_COUNT], z[GIFILT__LANE_COUNT];
    int l;
    gifilt__lanes_store(x, a.x);
    gifilt__lanes_store(y, a.y);
    gifilt__lanes_store(z, a.z);
    for (l = 0; l < GIFILT__LANE_COUNT; l++) {
        xyz[3 * l] = x[l];
        xyz[3 * l + 1] = y[l];
        xyz[3 * l + 2] = z[l];
    }
#endif
}

/* ==== src/gifilter/kernels_alike.h ==== */

/* ---- kernels: which neighbours show the same surface ---- */

/* Positions and normals of as many neighbours in a row as there are lanes. */
typedef struct gifilt__shapes { gifilt__lanes3 position, normal; } gifilt__shapes;

/* Loads shapes from planes that are s floats apart. */
static inline GIFILT__IN_KERNEL gifilt__shapes gifilt__shapes_load(const float *p, size_t s)
{
    gifilt__shapes a;
    a.position = gifilt__lanes3_load(p, p + s, p + 2 * s);
    a.normal = gifilt__lanes3_load(p + 3 * s, p + 4 * s, p + 5 * s);
    return a;
}

/* Returns how much neighbours b count for a, from 0 to 1: 0 if the normals differ by more than the limit or b
   lies off the plane of a, and falling smoothly to these. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__alike(const gifilt__shapes *a, const gifilt__shapes *b,
                                                            const float limits[3])
{
    const gifilt__lanes zero = gifilt__lanes_all(0.0f), one = gifilt__lanes_all(1.0f);
    const gifilt__lanes3 d = gifilt__lanes3_sub(b->position, a->position);
    const gifilt__lanes d2 = gifilt__lanes3_dot(d, d), off = gifilt__lanes3_dot(a->normal, d);
    const gifilt__lanes width2 = gifilt__lanes_mul(gifilt__lanes_all(limits[2]), d2);
    const gifilt__lanes slope2 = gifilt__lanes_div(gifilt__lanes_mul(off, off),
                                                   gifilt__lanes_add(width2, gifilt__lanes_all(1e-12f)));
    gifilt__lanes facing = gifilt__lanes3_dot(a->normal, b->normal);
    facing = gifilt__lanes_sub(facing, gifilt__lanes_all(limits[0]));
    facing = gifilt__lanes_mul(facing, gifilt__lanes_all(limits[1]));
    facing = gifilt__lanes_min(gifilt__lanes_max(facing, zero), one);
    return gifilt__lanes_mul(facing, gifilt__lanes_max(gifilt__lanes_sub(one, slope2), zero));
}

/* ==== src/gifilter/temporal.h ==== */

/* ---- kernels: what the last frames knew of each pixel ---- */

/* Marks the lanes whose absolute value is at most `most`; what is not a number is never marked. */
static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__at_most(gifilt__lanes a, float most)
{
    return gifilt__lanes_at_least(gifilt__lanes_all(most), gifilt__lanes_abs(a));
}

static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__at_most3(gifilt__lanes3 a, float most)
{
    const gifilt__lane_mask m = gifilt__mask_and(gifilt__at_most(a.x, most), gifilt__at_most(a.y, most));
    return gifilt__mask_and(m, gifilt__at_most(a.z, most));
}

/* Marks the vectors of which a coordinate is above or below 0; one that has no number in it is not marked. */
static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__not_zero(gifilt__lanes3 a)
{
    const gifilt__lanes zero = gifilt__lanes_all(0.0f);
    const gifilt__lane_mask m = gifilt__mask_or(gifilt__lanes_greater(gifilt__lanes_abs(a.x), zero),
                                                gifilt__lanes_greater(gifilt__lanes_abs(a.y), zero));
    return gifilt__mask_or(m, gifilt__lanes_greater(gifilt__lanes_abs(a.z), zero));
}

static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__are_there(const gifilt__chunk *k, size_t l)
{
    return gifilt__lanes_greater(gifilt__lanes_load(k->there + l), gifilt__lanes_all(0.0f));
}

static inline GIFILT__IN_KERNEL void gifilt__set_there(gifilt__chunk *k, size_t l, gifilt__lane_mask there)
{
    gifilt__lanes_store(k->there + l, gifilt__lanes_keep(there, gifilt__lanes_all(1.0f)));
}

/* Finds which pixels of a chunk show something, and copies what this frame sees of them. */
static inline GIFILT__IN_KERNEL void gifilt__chunk_set(gifilt__chunk *k)
{
    const gifilt__lanes least = gifilt__lanes_all(1e-12f);
    size_t l, c;
    for (l = 0; l < GIFILT__SPAN; l += GIFILT__LANE_COUNT) {
        const float (*g)[GIFILT__SPAN + 1] = (const float (*)[GIFILT__SPAN + 1])k->given;
        const gifilt__lanes3 p = gifilt__lanes3_load(g[0] + l, g[1] + l, g[2] + l);
        const gifilt__lanes3 n = gifilt__lanes3_load(g[3] + l, g[4] + l, g[5] + l);
        const gifilt__lanes3 next = gifilt__lanes3_load(g[0] + l + 1, g[1] + l + 1, g[2] + l + 1);
        const gifilt__lanes3 d = gifilt__lanes3_sub(next, p);
        const gifilt__lanes d2 = gifilt__lanes3_dot(d, d);
        const gifilt__lanes far2 = gifilt__lanes_add(gifilt__lanes_mul(gifilt__lanes_all(16.0f), d2), least);
        gifilt__lane_mask there = gifilt__mask_and(gifilt__at_most3(p, 1e9f), gifilt__at_most3(n, 1e9f));
        there = gifilt__mask_and(there, gifilt__not_zero(n));
        for (c = 0; c < GIFILT__RGB; c++)
            gifilt__lanes_store(k->now[c] + l, gifilt__lanes_keep(there, gifilt__lanes_load(g[c] + l)));
        for (; c < GIFILT__FRAMES; c++) {
            const gifilt__lanes light = gifilt__lanes_load(g[c] + l);
            const gifilt__lane_mask good = gifilt__mask_and(there, gifilt__at_most(light, GIFILT__MAX_LIGHT));
            gifilt__lanes_store(k->now[c] + l, gifilt__lanes_keep(good, light));
        }
        gifilt__lanes_store(k->size2 + l, gifilt__lanes_select(
            gifilt__lanes_greater(gifilt__lanes_all(1e18f), d2), far2, least));
        gifilt__set_there(k, l, there);
        gifilt__lanes_store(k->now[GIFILT__FRAMES] + l, gifilt__lanes_load(k->there + l));
    }
}

/* Loads pixels x to x + end - 1 of row y, and the place of the pixel after them: the distance between
   neighbours says how far from a pixel the last frame may have seen the same surface, which is four of them.
   */
GIFILT__HOT GIFILT__KERNEL static void gifilt__chunk_load(const gifilt__filter_run *r, gifilt__chunk *k,
                                                          size_t x, size_t y, size_t end)
{
    size_t ps = gifilt__stride(r->points->position_stride, 12) / 4,
           ns = gifilt__stride(r->points->normal_stride, 12) / 4;
    size_t at = y * r->filter->width + x, c;
    const float *p = r->points->positions + ps * at, *n = r->points->normals + ns * at,
                *light = r->in + 3 * at;
    if (end == GIFILT__SPAN && ps == 3 && ns == 3) gifilt__chunk_read(k, p, 3, n, 3, light, GIFILT__SPAN);
    else {
        memset(k->given, 0, sizeof k->given);
        gifilt__chunk_read(k, p, ps, n, ns, light, end);
    }
    for (c = 0; c < 3; c++)
        if (x + end < r->filter->width) k->given[c][end] = p[ps * end + c];
        else k->given[c][end] = end > 1 ? k->given[c][end - 2] : x > 0 ? *(p + c - ps) : p[c];
    gifilt__chunk_set(k);
}

/* Returns 1 if a normal of the chunk is neither unit nor 0 0 0 nor infinite. */
static inline GIFILT__IN_KERNEL int gifilt__chunk_wrong(const gifilt__chunk *k)
{
    int wrong = 0;
    size_t l;
    for (l = 0; l < GIFILT__SPAN; l += GIFILT__LANE_COUNT) {
        const gifilt__lanes3 n = gifilt__lanes3_load(k->given[3] + l, k->given[4] + l, k->given[5] + l);
        const gifilt__lanes length2 = gifilt__lanes3_dot(n, n);
        gifilt__lane_mask bad = gifilt__mask_or(
            gifilt__lanes_greater(gifilt__lanes_all(GIFILT__UNIT_LEAST2), length2),
            gifilt__lanes_greater(length2, gifilt__lanes_all(GIFILT__UNIT_MOST2)));
        bad = gifilt__mask_and(bad, gifilt__not_zero(n));
        bad = gifilt__mask_and(bad, gifilt__at_most(length2, GIFILT__MAX_FLOAT));
        wrong |= gifilt__mask_any(bad);
    }
    return wrong;
}

/* Returns a row of a matrix times places. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__row_times(const float *m, gifilt__lanes3 p)
{
    const gifilt__lanes3 row = gifilt__lanes3_all(m[0], m[4], m[8]);
    return gifilt__lanes_add(gifilt__lanes3_dot(row, p), gifilt__lanes_all(m[12]));
}

/* Finds where in the last frame's picture the pixels' places were, by that frame's matrix. */
GIFILT__HOT GIFILT__KERNEL static void gifilt__chunk_project(const gifilt__filter_run *r, gifilt__chunk *k)
{
    const float *m = r->filter->matrix, up = r->frame->rows == GIFILT_ROWS_TOP_FIRST ? -0.5f : 0.5f;
    const gifilt__lanes width = gifilt__lanes_all((float)r->filter->width), half = gifilt__lanes_all(0.5f);
    const gifilt__lanes height = gifilt__lanes_all((float)r->filter->height), down = gifilt__lanes_all(up);
    size_t l;
    for (l = 0; l < GIFILT__SPAN; l += GIFILT__LANE_COUNT) {
        const gifilt__lanes3 p = gifilt__lanes3_load(k->now[0] + l, k->now[1] + l, k->now[2] + l);
        const gifilt__lanes w = gifilt__row_times(m + 3, p);
        gifilt__lanes x = gifilt__lanes_div(gifilt__row_times(m, p), w);
        gifilt__lanes y = gifilt__lanes_div(gifilt__row_times(m + 1, p), w);
        x = gifilt__lanes_add(half, gifilt__lanes_mul(half, x));
        y = gifilt__lanes_add(half, gifilt__lanes_mul(down, y));
        gifilt__lanes_store(k->x + l, gifilt__lanes_mul(x, width));
        gifilt__lanes_store(k->y + l, gifilt__lanes_mul(y, height));
        gifilt__set_there(k, l, gifilt__mask_and(gifilt__are_there(k, l),
                                                 gifilt__lanes_greater(w, gifilt__lanes_all(0.0f))));
    }
}

/* Marks places that lie no more than a pixel out of the picture. */
static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__near_picture(gifilt__lanes x, float size)
{
    return gifilt__mask_and(gifilt__lanes_greater(x, gifilt__lanes_all(-1.0f)),
                            gifilt__lanes_greater(gifilt__lanes_all(size), x));
}

/* Finds between which two pixels places lie, and how far from the first. A place within 1/64 of a pixel's
   centre counts as the centre: a camera that stands still then finds one pixel, not four with weights of
   rounding, and does not blur. */
static inline GIFILT__IN_KERNEL void gifilt__place_axis(gifilt__lane_mask there, const float *place,
                                                        float *pixel, float *between)
{
    const gifilt__lanes eight = gifilt__lanes_all(8.0f);
    gifilt__lanes x = gifilt__lanes_add(gifilt__lanes_load(place), gifilt__lanes_all(7.5f)), centre, whole;
    x = gifilt__lanes_select(there, x, eight);
    centre = gifilt__lanes_of_ints(gifilt__lanes_truncate(gifilt__lanes_add(x, gifilt__lanes_all(0.5f))));
    x = gifilt__lanes_select(gifilt__lanes_greater(gifilt__lanes_all(1.0f / 64.0f),
                                                   gifilt__lanes_abs(gifilt__lanes_sub(x, centre))), centre,
                                                   x);
    whole = gifilt__lanes_of_ints(gifilt__lanes_truncate(x));           /* above 0: this rounds down */
    gifilt__lanes_store(pixel, gifilt__lanes_sub(whole, eight));
    gifilt__lanes_store(between, gifilt__lanes_sub(x, whole));
}

GIFILT__HOT GIFILT__KERNEL static void gifilt__chunk_place(const gifilt__filter_run *r, gifilt__chunk *k)
{
    const float width = (float)r->filter->width + 1.0f, height = (float)r->filter->height + 1.0f;
    size_t l;
    for (l = 0; l < GIFILT__SPAN; l += GIFILT__LANE_COUNT) {
        gifilt__lane_mask there = gifilt__mask_and(gifilt__near_picture(gifilt__lanes_load(k->x + l), width),
                                                   gifilt__near_picture(gifilt__lanes_load(k->y + l),
                                                                        height));
        there = gifilt__mask_and(there, gifilt__are_there(k, l));
        gifilt__set_there(k, l, there);
        gifilt__place_axis(there, k->x + l, k->i + l, k->u + l);
        gifilt__place_axis(there, k->y + l, k->j + l, k->v + l);
    }
}

static inline GIFILT__IN_KERNEL void gifilt__add_to(float *sum, gifilt__lanes a)
{
    gifilt__lanes_store(sum, gifilt__lanes_add(gifilt__lanes_load(sum), a));
}

/* Adds pixels of the last frame, planes t floats apart from q on, for those of the chunk from o on, where
   they show the same surface. */
static inline GIFILT__IN_KERNEL void gifilt__chunk_recall(const gifilt__filter_run *r, gifilt__chunk *k,
                                                          size_t o, const float *q, size_t t,
                                                          gifilt__lanes weight)
{
    const gifilt__shapes now = gifilt__shapes_load(&k->now[0][o], GIFILT__SPAN);
    const gifilt__shapes past = gifilt__shapes_load(q, t);
    const gifilt__lanes3 e = gifilt__lanes3_sub(past.position, now.position);
    const gifilt__lanes frames = gifilt__lanes_load(q + 9 * t), size2 = gifilt__lanes_load(k->size2 + o);
    gifilt__lane_mask nearby = gifilt__lanes_greater(frames, gifilt__lanes_all(0.0f));
    nearby = gifilt__mask_and(nearby, gifilt__lanes_at_least(size2, gifilt__lanes3_dot(e, e)));
    if (r->frame->motion) {
        const gifilt__lanes cosine = gifilt__lanes3_dot(now.normal, past.normal);
        const gifilt__lane_mask same = gifilt__lanes_greater(cosine, gifilt__lanes_all(0.5f));
        weight = gifilt__lanes_mul(gifilt__lanes_keep(same, gifilt__lanes_all(1.0f)), weight);
    } else weight = gifilt__lanes_mul(gifilt__alike(&now, &past, r->limits), weight);
    weight = gifilt__lanes_keep(nearby, weight);
    gifilt__add_to(k->sums[0] + o, gifilt__lanes_mul(weight, gifilt__lanes_load(q + 6 * t)));
    gifilt__add_to(k->sums[1] + o, gifilt__lanes_mul(weight, gifilt__lanes_load(q + 7 * t)));
    gifilt__add_to(k->sums[2] + o, gifilt__lanes_mul(weight, gifilt__lanes_load(q + 8 * t)));
    gifilt__add_to(k->sums[3] + o, gifilt__lanes_mul(weight, frames));
    gifilt__add_to(k->sums[4] + o, weight);
}


/* ==== src/gifilter/temporal_past.h ==== */

/* ---- kernels: pixels of the last frame ---- */

/* Writes the least of `low` and the greatest of `high` over all lanes. */
static inline GIFILT__IN_KERNEL void gifilt__range_of(gifilt__lanes low, gifilt__lanes high, int32_t *least,
                                                      int32_t *greatest)
{
    float lows[GIFILT__LANE_COUNT], highs[GIFILT__LANE_COUNT];
    int l;
    gifilt__lanes_store(lows, low);
    gifilt__lanes_store(highs, high);
    for (l = 1; l < GIFILT__LANE_COUNT; l++) {
        lows[0] = lows[l] < lows[0] ? lows[l] : lows[0];
        highs[0] = highs[l] > highs[0] ? highs[l] : highs[0];
    }
    *least = (int32_t)lows[0];
    *greatest = (int32_t)highs[0];
}

/* Finds which columns, less the pixels' own numbers, and rows of the last frame `count` pixels from o on were
   at. Returns -1 if none of them was seen, 1 if they lay in a row as they do now, but for one column or row
   more or less, and 0 if they did not. */
static inline GIFILT__IN_KERNEL int gifilt__chunk_range(const gifilt__chunk *k, size_t o, size_t count,
                                                        int32_t low[2], int32_t high[2])
{
    const gifilt__lanes most = gifilt__lanes_all(16777216.0f), least = gifilt__lanes_all(-16777216.0f);
    const gifilt__lanes numbers = gifilt__lanes_load(gifilt__numbers);
    gifilt__lanes a = most, b = least, c = most, d = least;
    size_t l;
    for (l = o; l < o + count; l += GIFILT__LANE_COUNT) {
        const gifilt__lane_mask there = gifilt__are_there(k, l);
        const gifilt__lanes own = gifilt__lanes_add(numbers, gifilt__lanes_all((float)l));
        const gifilt__lanes i = gifilt__lanes_sub(gifilt__lanes_load(k->i + l), own);
        const gifilt__lanes j = gifilt__lanes_load(k->j + l);
        a = gifilt__lanes_min(gifilt__lanes_select(there, i, most), a);
        b = gifilt__lanes_max(gifilt__lanes_select(there, i, least), b);
        c = gifilt__lanes_min(gifilt__lanes_select(there, j, most), c);
        d = gifilt__lanes_max(gifilt__lanes_select(there, j, least), d);
    }
    gifilt__range_of(a, b, &low[0], &high[0]);
    gifilt__range_of(c, d, &low[1], &high[1]);
    return low[0] > high[0] ? -1 : high[0] - low[0] <= 1 && high[1] - low[1] <= 1;
}

/* Returns the bilinear weight of a pixel that lies d pixels after the first of two for a place at u between
   them; if d is neither 0 nor 1, takes the lane out of *one. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__share(gifilt__lanes d, gifilt__lanes u,
                                                            gifilt__lane_mask *one)
{
    const gifilt__lanes zero = gifilt__lanes_all(0.0f), last = gifilt__lanes_all(1.0f);
    *one = gifilt__mask_and(*one, gifilt__lanes_at_least(d, zero));
    *one = gifilt__mask_and(*one, gifilt__lanes_at_least(last, d));
    return gifilt__lanes_select(gifilt__lanes_differ(d, zero), u, gifilt__lanes_sub(last, u));
}

/* Adds runs of the last frame's pixels, at most 3 x 3: columns and rows from low to one after high. */
static inline GIFILT__IN_KERNEL void gifilt__past_runs(const gifilt__filter_run *r, gifilt__chunk *k,
                                                       size_t o, const int32_t low[2], const int32_t high[2])
{
    const gifilt_filter *f = r->filter;
    const gifilt__lanes numbers = gifilt__lanes_load(gifilt__numbers), rows = gifilt__lanes_load(k->j + o);
    const gifilt__lanes own = gifilt__lanes_add(numbers, gifilt__lanes_all((float)o));
    const gifilt__lanes column = gifilt__lanes_sub(own, gifilt__lanes_load(k->i + o));
    int32_t i, j;
    for (j = low[1]; j <= high[1] + 1; j++)
        for (i = low[0]; i <= high[0] + 1; i++) {
            const gifilt__lanes dx = gifilt__lanes_add(gifilt__lanes_all((float)i), column);
            const gifilt__lanes dy = gifilt__lanes_sub(gifilt__lanes_all((float)j), rows);
            gifilt__lane_mask one = gifilt__are_there(k, o);
            gifilt__lanes weight = gifilt__share(dx, gifilt__lanes_load(k->u + o), &one);
            weight = gifilt__lanes_mul(weight, gifilt__share(dy, gifilt__lanes_load(k->v + o), &one));
            weight = gifilt__lanes_keep(one, weight);
            if (gifilt__mask_any(gifilt__lanes_greater(weight, gifilt__lanes_all(0.0f))) && j >= 0 &&
                j < (int32_t)f->height) {
                const float *row = f->history + (size_t)j * GIFILT__PLANES * f->spacing;
                gifilt__chunk_recall(r, k, o, row + (i + (int32_t)o), f->spacing, weight);
            }
        }
}

/* Adds the four pixels of the last frame about each place, fetched one by one. */
static inline GIFILT__IN_KERNEL void gifilt__past_each(const gifilt__filter_run *r, gifilt__chunk *k,
                                                       size_t o)
{
    const gifilt_filter *f = r->filter;
    float room[GIFILT__PLANES][GIFILT__LANE_COUNT], weights[GIFILT__LANE_COUNT];
    size_t l, c;
    int32_t n;
    for (n = 0; n < 4; n++) {
        for (l = 0; l < GIFILT__LANE_COUNT; l++) {
            const int32_t x = (int32_t)k->i[o + l] + (n & 1), y = (int32_t)k->j[o + l] + (n >> 1);
            const int inside = k->there[o + l] > 0.0f && x >= 0 && y >= 0 && x < (int32_t)f->width &&
                               y < (int32_t)f->height;
            const float *q = inside ? f->history + (size_t)y * GIFILT__PLANES * f->spacing + (size_t)x : NULL;
            weights[l] =
                (n & 1 ? k->u[o + l] : 1.0f - k->u[o + l]) * (n & 2 ? k->v[o + l] : 1.0f - k->v[o + l]);
            for (c = 0; c < GIFILT__PLANES; c++) room[c][l] = q ? q[c * f->spacing] : 0.0f;
        }
        gifilt__chunk_recall(r, k, o, room[0], GIFILT__LANE_COUNT, gifilt__lanes_load(weights));
    }
}

/* Sums the four pixels of the last frame about each place, with bilinear weights. If neighbours were
   neighbours then, but for one column or row, as in most chunks, whole runs of pixels are read; otherwise
   each pixel is fetched alone. */
GIFILT__HOT GIFILT__KERNEL static void gifilt__chunk_past(const gifilt__filter_run *r, gifilt__chunk *k)
{
    int32_t low[2], high[2];
    size_t o;
    int whole = gifilt__chunk_range(k, 0, GIFILT__SPAN, low, high), run = whole;
    memset(k->sums, 0, sizeof k->sums);
    for (o = 0; o < GIFILT__SPAN && whole >= 0; o += GIFILT__LANE_COUNT) {
        if (!whole) run = gifilt__chunk_range(k, o, GIFILT__LANE_COUNT, low, high);
        if (run > 0) gifilt__past_runs(r, k, o, low, high);
        else if (run == 0) gifilt__past_each(r, k, o);
    }
}

/* Mixes what the last frames knew into what this one sees. */
GIFILT__HOT GIFILT__KERNEL static void gifilt__chunk_blend(gifilt__chunk *k, float history)
{
    const gifilt__lanes least = gifilt__lanes_all(0.01f), zero = gifilt__lanes_all(0.0f);
    size_t l, c;
    for (l = 0; l < GIFILT__SPAN; l += GIFILT__LANE_COUNT) {
        const gifilt__lanes weights = gifilt__lanes_load(k->sums[4] + l);
        const gifilt__lanes past = gifilt__lanes_load(k->sums[3] + l);
        const gifilt__lanes sum = gifilt__lanes_max(weights, least);
        const gifilt__lanes more = gifilt__lanes_add(gifilt__lanes_div(past, sum), gifilt__lanes_all(1.0f));
        const gifilt__lanes frames = gifilt__lanes_min(more, gifilt__lanes_all(history));
        const gifilt__lane_mask there = gifilt__mask_and(gifilt__lanes_greater(weights, least),
                                                         gifilt__lanes_greater(past, zero));
        float *own = k->now[GIFILT__FRAMES] + l;
        gifilt__set_there(k, l, there);
        for (c = 0; c < 3; c++) {
            const gifilt__lanes now = gifilt__lanes_load(k->now[GIFILT__RGB + c] + l);
            const gifilt__lanes old = gifilt__lanes_div(gifilt__lanes_load(k->sums[c] + l), sum);
            const gifilt__lanes step = gifilt__lanes_div(gifilt__lanes_sub(now, old), frames);
            gifilt__lanes_store(k->now[GIFILT__RGB + c] + l,
                                gifilt__lanes_select(there, gifilt__lanes_add(old, step), now));
        }
        gifilt__lanes_store(own, gifilt__lanes_select(there, frames, gifilt__lanes_load(own)));
    }
}

GIFILT__HOT GIFILT__KERNEL static void gifilt__accumulate(const gifilt__filter_run *r, size_t y)
{
    const float *motion = r->frame->motion;
    size_t x, c, l;
    size_t width = r->filter->width, s = r->filter->spacing;
    gifilt__chunk k;
    int wrong = 0;
    for (x = 0; x < width; x += GIFILT__SPAN) {
        size_t end = width - x < GIFILT__SPAN ? width - x : (size_t)GIFILT__SPAN;
        float *to = r->filter->next + y * GIFILT__PLANES * s + x;
        gifilt__chunk_load(r, &k, x, y, end);
        wrong |= gifilt__chunk_wrong(&k);
        /* A surface that moved may be any distance from its old place. */
        for (l = 0; motion && l < GIFILT__SPAN; l++) {
            k.x[l] = l < end ? motion[2 * (y * width + x + l)] : 0.0f;
            k.y[l] = l < end ? motion[2 * (y * width + x + l) + 1] : 0.0f;
            k.size2[l] = GIFILT__FAR;
        }
        if (r->recalls) {
            /* Most cameras move little: the next row is wanted next. */
            for (l = 0; y + 1 < r->filter->height && l < end; l += GIFILT__WIDE)
                gifilt__fetch_ahead(r->filter->history + (y + 1) * GIFILT__PLANES * s + x + l, s,
                                    GIFILT__PLANES);
            if (!motion) gifilt__chunk_project(r, &k);
            gifilt__chunk_place(r, &k);
            gifilt__chunk_past(r, &k);
            gifilt__chunk_blend(&k, (float)r->history);
        }
        for (c = 0; c < GIFILT__PLANES; c++)
            if (end == GIFILT__SPAN) memcpy(to + c * s, k.now[c], sizeof k.now[c]);
            else memcpy(to + c * s, k.now[c], end * sizeof *to); /* margins stay 0 */
    }
    r->filter->wrong_rows[y] = (uint8_t)wrong;
}

/* ==== src/gifilter/atrous.h ==== */

/* ---- kernels: a-trous, the mean of neighbours that are alike ---- */

typedef struct gifilt__means { gifilt__lanes3 rgb, most; gifilt__lanes total; } gifilt__means;

/* Returns means, none of them brighter than the brightest neighbour if only few neighbours are like the
   pixel. In a mean over few the noise of the pixel's own samples stays: of 25 lights that stand for 400, one
   that is near counts 16 times. The mean's weights add up to 16 at most, of which 4 are the pixel's own. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__despeckled(gifilt__lanes sum, gifilt__lanes total,
                                                                 gifilt__lanes most, gifilt__lane_mask few)
{
    const gifilt__lanes x = gifilt__lanes_div(sum, total);
    const gifilt__lane_mask lit = gifilt__lanes_greater(most, gifilt__lanes_all(0.0f));
    few = gifilt__mask_and(gifilt__mask_and(few, lit), gifilt__lanes_greater(x, most));
    return gifilt__lanes_select(few, most, x);
}

/* Adds one neighbour of every lane to the means: its shape lies from q on, its colour from c on, in planes s
   floats apart. */
static inline GIFILT__IN_KERNEL gifilt__means gifilt__add_tap(gifilt__means means, const gifilt__shapes *own,
                                                              const float *q, const float *c, size_t s,
                                                              float share, const float limits[3])
{
    const gifilt__shapes shapes = gifilt__shapes_load(q, s);
    const gifilt__lanes3 rgb = gifilt__lanes3_load(c, c + s, c + 2 * s);
    const gifilt__lanes alike = gifilt__alike(own, &shapes, limits);
    const gifilt__lanes weight = gifilt__lanes_mul(alike, gifilt__lanes_all(share));
    means.rgb.x = gifilt__lanes_add(means.rgb.x, gifilt__lanes_mul(weight, rgb.x));
    means.rgb.y = gifilt__lanes_add(means.rgb.y, gifilt__lanes_mul(weight, rgb.y));
    means.rgb.z = gifilt__lanes_add(means.rgb.z, gifilt__lanes_mul(weight, rgb.z));
    means.total = gifilt__lanes_add(means.total, weight);
    means.most.x = gifilt__lanes_max(rgb.x, means.most.x);
    means.most.y = gifilt__lanes_max(rgb.y, means.most.y);
    means.most.z = gifilt__lanes_max(rgb.z, means.most.z);
    return means;
}

/* Takes one pass of the a-trous filter on as many pixels as there are lanes. */
static inline GIFILT__IN_KERNEL gifilt__lanes3 gifilt__smooth_some(const gifilt__filter_run *r,
                                                                   const float *p,
                                                                   const float *rgb, const gifilt__tap *taps,
                                                                   size_t count)
{
    const float limits[3] = { r->limits[0], r->limits[1], r->limits[2] };
    const size_t s = r->filter->spacing;
    const gifilt__shapes own = gifilt__shapes_load(p, s);
    const gifilt__lanes four = gifilt__lanes_all(4.0f);
    gifilt__means means;
    gifilt__lanes3 out;
    gifilt__lane_mask few;
    size_t k;
    means.rgb.x = gifilt__lanes_mul(four, gifilt__lanes_load(rgb));
    means.rgb.y = gifilt__lanes_mul(four, gifilt__lanes_load(rgb + s));
    means.rgb.z = gifilt__lanes_mul(four, gifilt__lanes_load(rgb + 2 * s));
    means.total = four;
    means.most = gifilt__lanes3_all(0.0f, 0.0f, 0.0f);
    for (k = 0; k < count; k++)
        means = gifilt__add_tap(means, &own, p + taps[k].shape, rgb + taps[k].rgb, s, taps[k].weight, limits);
    few = gifilt__lanes_greater(gifilt__lanes_all(8.0f), means.total);
    out.x = gifilt__despeckled(means.rgb.x, means.total, means.most.x, few);
    out.y = gifilt__despeckled(means.rgb.y, means.total, means.most.y, few);
    out.z = gifilt__despeckled(means.rgb.z, means.total, means.most.z, few);
    return out;
}

/* Takes one pass on a row: means over 3 x 3 pixels that are r->step apart. */
GIFILT__KERNEL static void gifilt__smooth(const gifilt__filter_run *r, size_t y)
{
    const gifilt_filter *f = r->filter;
    const float *p = f->next + y * GIFILT__PLANES * f->spacing, *rgb = r->in + y * r->in_row;
    float *to = r->out + y * r->out_row, some[3 * GIFILT__LANE_COUNT];
    const size_t lanes = GIFILT__LANE_COUNT;
    size_t x, c, width = f->width;
    gifilt__tap taps[8];
    size_t count = gifilt__taps(r, y, taps), below = y + r->step + 1 < f->height ? r->step + 1 : 0;
    size_t ahead = below * GIFILT__PLANES * f->spacing, rgb_ahead = below * r->in_row;
    for (x = 0; x < width; x += lanes) {
        size_t end = width - x < lanes ? width - x : lanes;
        gifilt__lanes3 out;
        gifilt__fetch_ahead(p + x + ahead, f->spacing, GIFILT__RGB);
        gifilt__fetch_ahead(rgb + x + rgb_ahead, f->spacing, 3);
        out = gifilt__smooth_some(r, p + x, rgb + x, taps, count);
        if (r->packed) {
            gifilt__lanes3_store_packed(some, out);
            memcpy(to + 3 * x, some, 3 * end * sizeof *to);
            continue;
        }
        gifilt__lanes_store(some, out.x);
        gifilt__lanes_store(some + lanes, out.y);
        gifilt__lanes_store(some + 2 * lanes, out.z);
        for (c = 0; c < 3; c++)
            if (end == lanes) memcpy(to + c * f->spacing + x, some + c * lanes, lanes * sizeof *to);
            else memcpy(to + c * f->spacing + x, some + c * lanes, end * sizeof *to);   /* margins stay 0 */
    }
}

/* ==== src/gifilter/kernels_end.h ==== */

#undef GIFILT__SET
#undef GIFILT__WIDTH
#undef GIFILT__LANE_COUNT
#endif /* GIFILT__SET */

#if defined(GIFILTER_IMPLEMENTATION) && !defined(GIFILTER_IMPLEMENTED)
#define GIFILTER_IMPLEMENTED

/* ---- kernels: those of other instruction sets, and which to call ---- */

#if GIFILT__SIMD_SETS
#define GIFILT__SET avx2
#define GIFILT__WIDTH 8
#define GIFILT__LANE_COUNT 8
#include GIFILT__FILE
#define GIFILT__SET avx512
#define GIFILT__WIDTH 16
#define GIFILT__LANE_COUNT 16
#include GIFILT__FILE
#endif

static inline void gifilt__choose_filter(gifilt__filter_run *r)
{
    r->accumulate = gifilt__accumulate_plain;
    r->smooth = gifilt__smooth_plain;
#if GIFILT__SIMD_SETS
    if (gifilt__simd_level() == 1) {
        r->accumulate = gifilt__accumulate_avx2;
        r->smooth = gifilt__smooth_avx2;
    }
    if (gifilt__simd_level() == 2) {
        r->accumulate = gifilt__accumulate_avx512;
        r->smooth = gifilt__smooth_avx512;
    }
#endif
}

/* ==== src/gifilter/filter.h ==== */

/* ---- filter: frames ---- */

/* Returns how many floats a row takes: the picture's width and a margin, but no multiple of 64, for rows that
   far apart push each other out of the cache. */
static inline size_t gifilt__row_floats(uint32_t width)
{
    size_t spacing = (size_t)width + GIFILT__MARGIN;
    return spacing + (spacing % 64u ? 0u : 16u);
}

/* Allocates the filter's memory, whose size the caller checked: two pictures, with a margin before the first
   row and after the last one, where lanes reach beyond it. If this fails, the caller frees what there is. */
static inline gifilt_result gifilt__take_memory(gifilt_filter *f, size_t floats, const gifilt__allocator *a)
{
    f->memory[0] = (float *)gifilt__alloc_array(a, floats, sizeof(float));
    f->memory[1] = (float *)gifilt__alloc_array(a, floats, sizeof(float));
    f->wrong_rows = (uint8_t *)gifilt__alloc_array(a, f->height, 1);
    if (!f->memory[0] || !f->memory[1] || !f->wrong_rows) return GIFILT_ERR_ALLOC;
    memset(f->memory[0], 0, floats * sizeof(float));
    memset(f->memory[1], 0, floats * sizeof(float));
    f->history = f->memory[0] + GIFILT__MARGIN;
    f->next = f->memory[1] + GIFILT__MARGIN;
    return GIFILT_OK;
}

GIFILT_DEF gifilt_result gifilt_create(const gifilt_desc *desc, gifilt_filter **out)
{
    gifilt__logger log = gifilt__logger_of(desc ? &desc->system : NULL, "gifilt_create");
    gifilt__allocator a;
    gifilt_filter *f;
    size_t floats;
    if (!desc) return GIFILT_ERR_ARGUMENT;
    if (!out) return gifilt__refuse(&log, GIFILT_ERR_ARGUMENT, "out", "is NULL");
    if (!gifilt__check_range(&log, "desc.width", desc->width, 1, 65536, "1..65536")) return GIFILT_ERR_DESC;
    if (!gifilt__check_range(&log, "desc.height", desc->height, 1, 65536, "1..65536")) return GIFILT_ERR_DESC;
    if (!gifilt__system_valid(&log, &desc->system)) return GIFILT_ERR_DESC;
    if (!gifilt__mul_size(gifilt__row_floats(desc->width) * GIFILT__PLANES, desc->height, &floats) ||
        !gifilt__add_size(floats, 2 * GIFILT__MARGIN, &floats) || floats > SIZE_MAX / sizeof(float)) {
        gifilt__log_value(&log, "desc.width x desc.height", (double)desc->width * (double)desc->height,
                          "less: the filter's memory does not fit a size_t");
        return GIFILT_ERR_LIMIT;
    }
    a = gifilt__allocator_of(&desc->system);
    f = (gifilt_filter *)gifilt__alloc(&a, sizeof *f);
    if (!f) return gifilt__refuse(&log, GIFILT_ERR_ALLOC, "desc.system.allocator", "returned no memory");
    memset(f, 0, sizeof *f);
    f->system = desc->system;
    f->width = desc->width;
    f->height = desc->height;
    f->spacing = gifilt__row_floats(desc->width);
    if (gifilt__take_memory(f, floats, &a) != GIFILT_OK) {
        gifilt_free(f);
        return gifilt__refuse(&log, GIFILT_ERR_ALLOC, "desc.system.allocator", "returned no memory");
    }
    *out = f;
    return GIFILT_OK;
}

GIFILT_DEF void gifilt_free(gifilt_filter *filter)
{
    gifilt__allocator a;
    if (!filter) return;
    a = gifilt__allocator_of(&filter->system);
    gifilt__free(&a, filter->wrong_rows);
    gifilt__free(&a, filter->memory[1]);
    gifilt__free(&a, filter->memory[0]);
    gifilt__free(&a, filter);
}

GIFILT_DEF void gifilt_reset(gifilt_filter *filter)
{
    size_t y;
    if (!filter) return;
    for (y = 0; y < filter->height; y++)
        memset(filter->history + (y * GIFILT__PLANES + GIFILT__FRAMES) * filter->spacing, 0,
               filter->width * sizeof *filter->history);
    filter->has_matrix = 0;
}

/* Writes a row that no pass has filtered: three floats a pixel, from three rows of floats. */
static inline void gifilt__pack(const gifilt__filter_run *r, size_t y)
{
    size_t x, c, width = r->filter->width;
    for (x = 0; x < width; x++)
        for (c = 0; c < 3; c++)
            r->out[3 * (y * width + x) + c] = r->in[y * r->in_row + c * r->filter->spacing + x];
}

/* Filters the rows of one task. They are neighbours, so that the rows above were mostly fetched by the same
   thread. */
static inline void gifilt__filter_band(void *context, size_t band)
{
    const gifilt__filter_run *r = (const gifilt__filter_run *)context;
    size_t y, end = (band + 1) * GIFILT__TASK_ROWS;
    for (y = band * GIFILT__TASK_ROWS; y < end && y < r->filter->height; y++) r->row(r, y);
}

static inline void gifilt__filter_rows(gifilt__filter_run *r, gifilt__filter_row row)
{
    r->row = row;
    gifilt__run(&r->filter->system, (r->filter->height + GIFILT__TASK_ROWS - 1) / GIFILT__TASK_ROWS,
                gifilt__filter_band, r);
}

/* Takes the passes from f->next to out. Passes between the first and the last write over the last frame,
   which nothing asks for any more: over its positions and its normals in turn. */
static inline void gifilt__filter_passes(gifilt__filter_run *r, float *out)
{
    gifilt_filter *f = r->filter;
    const uint32_t passes = r->frame->passes == 0  ? 2u
                            : r->frame->passes < 0 ? 0u
                                                   : (uint32_t)r->frame->passes;
    uint32_t pass;
    r->in = f->next + GIFILT__RGB * f->spacing;
    r->in_row = GIFILT__PLANES * f->spacing;
    r->out = out;
    if (passes == 0) gifilt__filter_rows(r, gifilt__pack);
    for (pass = 0; pass < passes; pass++) {
        r->packed = pass + 1 == passes;
        r->out = r->packed ? out : f->history + (pass % 2 ? 3 * f->spacing : 0);
        r->out_row = r->packed ? 3 * (size_t)f->width : GIFILT__PLANES * f->spacing;
        r->step = 1u << pass;
        gifilt__filter_rows(r, r->smooth);
        r->in = r->out;
    }
}

/* Writes this frame into f->next, mixed with what the last frames knew. Returns 0 if a normal is not unit;
   the frames before are then as they were. */
static inline int gifilt__filter_recall(gifilt__filter_run *r)
{
    const gifilt_filter *f = r->filter;
    const gifilt_frame *d = r->frame;
    size_t y;
    r->history = d->history ? d->history : 8;
    r->recalls = r->history > 1 && (d->motion || (d->world_to_clip && f->has_matrix));
    r->limits[0] = d->normal_cosine > 0.0f ? d->normal_cosine : 0.9f;
    r->limits[1] = 1.0f / (1.0f - r->limits[0]);
    r->limits[2] = d->plane_slope > 0.0f ? d->plane_slope * d->plane_slope : 0.1f * 0.1f;
    gifilt__filter_rows(r, r->accumulate);
    for (y = 0; y < f->height; y++)
        if (f->wrong_rows[y]) return 0;
    return 1;
}

/* Filters one frame, of a run that has its filter, its inputs and its kernels. Returns 0, and changes
   nothing, if a normal is not unit. */
static inline int gifilt__filter_frame(gifilt__filter_run *r, float *out)
{
    gifilt_filter *f = r->filter;
    const gifilt_frame *d = r->frame;
    float *swap;
    if (!gifilt__filter_recall(r)) return 0;
    gifilt__filter_passes(r, out);
    swap = f->history;
    f->history = f->next;
    f->next = swap;
    f->has_matrix = d->world_to_clip != NULL;
    if (d->world_to_clip) memcpy(f->matrix, d->world_to_clip, sizeof f->matrix);
    return 1;
}

static inline int gifilt__frame_valid(const gifilt__logger *log, const gifilt_frame *d)
{
    int i;
    if (!gifilt__check_range(log, "frame.rows", (double)d->rows, 0, GIFILT_ROWS_COUNT - 1,
                             "a value of gifilt_rows"))
        return 0;
    if (!gifilt__check_range(log, "frame.history", d->history, 0, 1000, "0..1000")) return 0;
    if (!gifilt__check_range(log, "frame.passes", d->passes, -1e9, 6, "at most 6")) return 0;
    if (!gifilt__check_range(log, "frame.normal_cosine", (double)d->normal_cosine, 0, 0.99999994,
                             "0 or more, below 1"))
        return 0;
    if (!gifilt__check_range(log, "frame.plane_slope", (double)d->plane_slope, 0, 1e6, "0..1e6")) return 0;
    for (i = 0; i < 16 && d->world_to_clip; i++)
        if (!gifilt__finite(d->world_to_clip[i])) {
            gifilt__log_element(log, "frame.world_to_clip", (uint64_t)i, "is",
                                (double)d->world_to_clip[i], "finite");
            return 0;
        }
    return 1;
}

/* Logs the first normal that is not unit, for a call that returns the result. */
static inline gifilt_result gifilt__refuse_normals(const gifilt__logger *log, const gifilt_points *p)
{
    size_t i, stride = gifilt__stride(p->normal_stride, 12) / 4;
    for (i = 0; i < p->count; i++) {
        gifilt__v3 n = gifilt__v3_load(p->normals + i * stride);
        float length2 = gifilt__v3_dot(n, n);
        if (!(length2 <= GIFILT__MAX_FLOAT) || gifilt__is_unit2(length2)) continue;
        if (n.x == 0.0f && n.y == 0.0f && n.z == 0.0f) continue;
        gifilt__log_element(log, "points.normals", i, "has the length", (double)gifilt__v3_length(n),
                            "1 (0.97..1.03), or 0");
        break;
    }
    return GIFILT_ERR_INPUT;
}

GIFILT_DEF gifilt_result gifilt_apply(gifilt_filter *filter, const gifilt_frame *frame,
                                      const gifilt_points *points, const float *light, float *out)
{
    gifilt__logger log = gifilt__logger_of(filter ? &filter->system : NULL, "gifilt_apply");
    gifilt__filter_run r;
    gifilt_frame none;
    memset(&none, 0, sizeof none);
    memset(&r, 0, sizeof r);
    if (!filter) return GIFILT_ERR_ARGUMENT;
    if (!light || !out) return gifilt__refuse(&log, GIFILT_ERR_ARGUMENT, light ? "out" : "light", "is NULL");
    if (!gifilt__points_valid(&log, points)) return GIFILT_ERR_ARGUMENT;
    if (points->count != (size_t)filter->width * filter->height) {
        gifilt__log_value(&log, "points.count", (double)points->count, "the filter's width x height");
        return GIFILT_ERR_MISMATCH;
    }
    r.frame = frame ? frame : &none;
    if (!gifilt__frame_valid(&log, r.frame)) return GIFILT_ERR_DESC;
    r.filter = filter;
    r.points = points;
    r.in = light;
    gifilt__choose_filter(&r);
    return gifilt__filter_frame(&r, out) ? GIFILT_OK : gifilt__refuse_normals(&log, points);
}

/* ==== src/shared/fp_end.h ==== */

/* unit fp_end: the user's options again. clang and MSVC keep contraction off to the end of the file. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__)
#pragma GCC pop_options
#endif

/* ==== src/gifilter/end.h ==== */

#endif /* GIFILTER_IMPLEMENTATION */

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

For more information, please refer to
<https://unlicense.org/> */
