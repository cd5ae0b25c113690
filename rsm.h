/* rsm.h - v1.0.0 - reflective shadow maps: one bounce of light from the texels of a shadow map - MIT-0 OR Unlicense

   What it does

   A shadow map that stores position, normal and reflected flux knows every surface that one bounce of its light can
   come from. After Dachsbacher and Stamminger, "Reflective Shadow Maps", I3D 2005: this header fills such maps from
   your renderer's buffers or from triangles, picks pixel lights from them, and gathers their light at points, per pixel
   with interpolation or a filter, or per vertex. Flux, weights and units are exact where the paper was not; docs/rsm.md
   says where.

   What it does not do

   - Nothing stands in the way of bounced light: surfaces behind others are lit too, as in the paper. An occlusion
     factor for each point (ambient occlusion) is taken as input; ism.h has real shadows.
   - One bounce only. No rendering of pictures, no threads of its own, no file access.

   Quick start

   In exactly one source file write the define; everywhere else include the header alone.

       #define RSM_IMPLEMENTATION
       #include "rsm.h"
       #include <stdio.h>

       int main(void)
       {
           static const float corners[] = { -1, 0, -1,  1, 0, -1,  1, 0, 1,  -1, 0, 1 };   // a floor, two units wide
           static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2 };
           const float above[3] = { 0, 1, 0 }, down[3] = { 0, -1, 0 };
           rsm_desc desc = { 0 };
           rsm_mesh mesh = { 0 };
           rsm_gather_desc gather = { 0 };
           rsm_points points = { 0 };
           rsm_map *map;
           float e[3];

           desc.light.direction[1] = 1;                     // the sun stands above
           desc.light.value[0] = desc.light.value[1] = desc.light.value[2] = 1;
           desc.light.radius = 1;                           // and its map covers the floor
           mesh.positions = corners;
           mesh.vertex_count = 4;
           mesh.indices = triangles;
           mesh.index_count = 6;
           mesh.albedo[0] = mesh.albedo[1] = mesh.albedo[2] = 0.5f;
           if (rsm_map_create(&desc, &map) != RSM_OK) return 1;
           if (rsm_rasterize(map, &mesh, 1) != RSM_OK || rsm_finish(map, NULL) != RSM_OK) return 1;
           points.count = 1;
           points.positions = above;
           points.normals = down;
           if (rsm_gather((const rsm_map *const *)&map, 1, &gather, &points, e, NULL) != RSM_OK) return 1;
           printf("irradiance from the floor: %.3f, exact 0.277\n", (double)e[0]);
           rsm_map_free(map);
           return !(e[0] > 0.27f && e[0] < 0.285f);
       }

   Conventions

   Right-handed; matrices are column-major float[16]; distances in your units, angles in radians; directions have unit
   length. Irradiance W/m^2, intensity W/sr, flux W. Linear colours: three floats.

     map        what one light sees: 1 face, or the faces of a cube: 5 about a patch's normal, 6 about a point
     texel      one pixel of a face, row by row, row 0 at the bottom (v = 0); also a pixel light: flux leaves it along
                its normal as from a diffuse surface, I = flux / pi cos
     receiver   a point that is lit by pixel lights; irradiance is written, so multiply by albedo / pi
     pattern    where a receiver takes its samples: texels about its own projection, or texels chosen by flux

   How it works

     rsm_map_create -> rsm_fill (your buffers) or rsm_rasterize (triangles), each face -> rsm_finish
       -> rsm_direct         direct light of receivers by the same map
       -> rsm_gather         bounced light of any receivers
       -> rsm_interpolate    the same for a picture: a coarse grid, refined where it does not do
       -> rsm_filter_apply   the same from few samples: over frames and over neighbours
       -> rsm_pixel_lights, rsm_cluster -> rsm_gather_list: one list of lights for all

   A map takes 56 bytes a texel (48 of them rsm_texel), a list of lights 48 bytes each, a gather 60 bytes a light in
   scratch (88 with materials), interpolation 11 bytes a pixel, the filter 80 bytes a pixel and 4 KB a row. The knobs,
   and what each trades:

     samples    fewer: banding (list and unrotated patterns) or noise (noise, interleave), and bright dots where
                surfaces meet; 0, the default, takes every texel
     pattern    FLUX is fastest; MIXED has the least error where the light near a corner matters
     offset     pixel lights move below their surface: tames corners, darkens them too (docs/rsm.md has the curve)
     near_limit the same by a bound on each light; what is lost is counted
     near_field near texels are surfaces, not points: corners without spots, for a tenth to a quarter more time
     size       fewer texels: blurred sources, spotted corners
     passes     of the filter: fewer: noise; more: light blurred where it falls off beside corners. 1 or 2 mostly do

   Configuration

     RSM_IMPLEMENTATION   in one source file: compiles the code
     RSM_STATIC           everywhere it is included: a private copy, all functions static
     RSM_DEF              everywhere: your own linkage instead
     RSM_NO_SIMD          with the implementation: portable code only (results are the same to the bit)

   Memory, errors, threads, determinism

   All memory comes from the allocator in the desc, called from the thread that called us. Every function that can fail
   returns an rsm_result; where it is not RSM_OK, outputs are untouched (where a contract does not say otherwise) and
   nothing leaks. No globals: finished maps may be used from any number of threads; a map being filled and a filter
   belong to one at a time. Same input, same bytes, on every compiler, processor, byte order and thread count (not with
   x87 arithmetic, nor with clang's -ffast-math).

   Cost: docs/rsm.md and build/bench rsm_gather.   History: CHANGELOG.md.   Licence: end of this file. */
#ifndef RSM_H
#define RSM_H

#define RSM_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#include <stddef.h>
#include <stdint.h>

#ifndef RSM_DEF
#ifdef RSM_STATIC
#define RSM_DEF static inline
#else
#define RSM_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- results ---- */

#define RSM_RESULTS(X)                                                                                       \
    X(RSM_OK, "ok")                                                                                          \
    X(RSM_ERR_ARGUMENT, "an argument is NULL, zero, not finite or out of range")                             \
    X(RSM_ERR_DESC, "a desc field is out of range")                                                          \
    X(RSM_ERR_INPUT, "a mesh or buffer cannot be used")                                                      \
    X(RSM_ERR_ALLOC, "the allocator returned no memory")                                                     \
    X(RSM_ERR_MEMORY, "the caller's buffer is too small or misaligned")                                      \
    X(RSM_ERR_LIMIT, "a size overflows or passes a limit")                                                   \
    X(RSM_ERR_CANCELLED, "cancelled by the progress callback")                                               \
    X(RSM_ERR_ORDER, "the map is not finished, or is already")

typedef enum rsm_result {
#define RSM__ENUM(name, text) name,
    RSM_RESULTS(RSM__ENUM)
#undef RSM__ENUM
    RSM_RESULT_COUNT
} rsm_result;

RSM_DEF const char *rsm_result_text(rsm_result result);
/* A constant string for any value, "unknown result" beyond the list. */

/* ---- memory, threads, progress: the caller's ---- */

typedef struct rsm_allocator {      /* all zero = malloc and free; else both functions */
    void *(*alloc_fn)(size_t size, void *user);   /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} rsm_allocator;

typedef void (*rsm_task)(void *context, size_t index);
typedef void (*rsm_parallel_for)(void *user, size_t count, rsm_task task, void *context);
/* Must call task(context, i) once for each i < count, in any order and on any threads, and return when all are done. */

typedef int (*rsm_progress)(void *user, float fraction);
/* Called between steps, from the thread that called us, fraction 0..1 never falling; not 0 cancels. */

typedef struct rsm_system {         /* all zero: malloc, this thread alone, no progress */
    rsm_allocator    allocator;
    rsm_parallel_for parallel_for;
    void            *parallel_user;
    rsm_progress     progress;
    void            *progress_user;
} rsm_system;

/* ---- maps ---- */

typedef enum rsm_light_kind {
    RSM_LIGHT_DEFAULT,              /* = RSM_LIGHT_SUN */
    RSM_LIGHT_SUN,                  /* parallel light; the map is a square of side 2 radius about position */
    RSM_LIGHT_SPOT,                 /* uniform intensity in a hard circular cone; above 2 rad the map is a cube */
    RSM_LIGHT_SQUARE_SPOT,          /* uniform intensity in a square pyramid: the whole map; below 2 rad */
    RSM_LIGHT_POINT,                /* uniform intensity all round: cube */
    RSM_LIGHT_PATCH,                /* piece of a diffuse emitter, I cos: half a cube. Several make an area light */
    RSM_LIGHT_KIND_COUNT
} rsm_light_kind;

typedef struct rsm_light {
    rsm_light_kind kind;
    float position[3];              /* sun: centre of what its map covers */
    float direction[3];             /* unit. Sun: towards it; spot: out of the lamp; patch: its normal; point: unused */
    float up[3];                    /* which way v grows; 0 0 0 = +Y, or +Z where direction is near it */
    float value[3];                 /* sun: irradiance facing it; spot, point: intensity; patch: that along its normal,
                                       radiance x area. 0..1e12 */
    float radius;                   /* sun: half side of the map, world units, > 0 */
    float cone_angle;               /* spot: full apex angle, above 0.001, at most 6.28; square: between opposite sides,
                                       at most 2 */
    float near_depth, far_depth;    /* depths that the map holds. 0 0 = -radius..radius (sun), 0.001..1000 (others); to
                                       set one set both */
} rsm_light;

typedef struct rsm_texel {          /* and a pixel light: 48 bytes */
    float    position[3];           /* of the surface at the texel's centre */
    float    depth;                 /* along the face's axis; sun: from position. RSM_FAR: nothing there */
    float    normal[3];             /* unit */
    uint32_t material;              /* index into rsm_gather_desc.materials, 0 = none */
    float    flux[3];               /* reflected: light through the texel x albedo */
    float    area;                  /* of surface that the texel stands for; 0 = unknown */
} rsm_texel;

#define RSM_FAR 3.0e38f

typedef struct rsm_desc {
    rsm_light  light;
    uint32_t   size;                /* texels a side of a face, 4..4096; 0 = 512, cubes 256 */
    int        clip_zero_to_one;    /* of rsm_map_matrix: not 0: z is 0..1 (Direct3D, Metal, Vulkan); 0: -1..1 (GL) */
    int        clip_y_down;         /* not 0: clip y points down in your pictures (Vulkan without a viewport of negative
                                       height): rsm_map_matrix is turned round */
    int        clip_top_first;      /* of your buffers: not 0: row 0 is at clip y = +1 (Direct3D, Metal; Vulkan with a
                                       viewport of negative height); 0: at clip y = -1 (OpenGL, Vulkan) */
    rsm_system system;
} rsm_desc;                         /* zero it, then set what you care about */

typedef struct rsm_map rsm_map;

RSM_DEF size_t rsm_map_size(const rsm_desc *desc);
/* Bytes of a map: 56 a texel, 8 a row and 1 KB at most. 0: the desc is refused. */

RSM_DEF rsm_result rsm_map_init(const rsm_desc *desc, void *memory, size_t size, rsm_map **out);
/* An empty map inside memory of yours: rsm_map_size(desc) bytes, 8-byte aligned, which must outlive *out. Nothing is
   allocated; for the next frame call it again on the same memory.
   Errors   RSM_ERR_DESC, RSM_ERR_ARGUMENT (NULL), RSM_ERR_MEMORY */

RSM_DEF rsm_result rsm_map_create(const rsm_desc *desc, rsm_map **out);
/* The same in memory of the desc's allocator. rsm_map_free gives it back. */

RSM_DEF rsm_result rsm_map_restart(rsm_map *map, const rsm_light *light);
/* Empties a map of either kind for the next frame, in the memory that it has.
   light    NULL = as it was; a map keeps its size, and its faces: a spot may widen to a cube in a cube's map alone
   Errors   RSM_ERR_ARGUMENT (NULL), RSM_ERR_DESC, RSM_ERR_MEMORY (more faces than the map was made with); the map is
            then as it was */

RSM_DEF void rsm_map_free(rsm_map *map);
/* Accepts NULL, and maps of rsm_map_init, which it leaves alone. */

RSM_DEF uint32_t rsm_map_faces(const rsm_map *map);   /* 1, 5 or 6 */
RSM_DEF uint32_t rsm_map_side(const rsm_map *map);    /* texels a side */

RSM_DEF const rsm_texel *rsm_map_texels(const rsm_map *map);
/* faces x size x size texels, as they are at this moment. */

RSM_DEF rsm_result rsm_map_matrix(const rsm_map *map, uint32_t face, float world_to_clip[16]);
/* What to render face with. Faces of a cube: forward, right, left, up, down, back in the frame of direction and up. */

RSM_DEF rsm_result rsm_map_project(const rsm_map *map, const float point[3], uint32_t *face, float uv[2],
                                   float *depth);
/* Where the light sees a point: uv in 0..1 where it lies inside the face; depth as in rsm_texel. depth <= 0 and a
   perspective map: behind it (face 0 of a patch's cube, which has none there), uv is the middle. */

typedef struct rsm_buffers {        /* one face as your renderer drew it: size rows of size pixels, nothing between */
    const float   *positions;       size_t position_stride;  /* world; strides: bytes a pixel, multiples of 4, 0 = 12 */
    const float   *depth;           size_t depth_stride;     /* of a depth buffer, 0..1; 0 = 4. Used where positions is
                                                                NULL; else, where not NULL, only 1 marks background */
    const float   *normals;         size_t normal_stride;    /* world; made unit. 0 0 0 marks background */
    const float   *albedo;          size_t albedo_stride;    /* linear reflectance, 0..1: more is not refused */
    const uint8_t *albedo_srgb;     size_t srgb_stride;      /* or 8-bit sRGB; 0 = 4 bytes a pixel. Both NULL: 1 */
    const uint32_t *materials;      size_t material_stride;  /* NULL: none; 0 = 4 */
} rsm_buffers;

RSM_DEF rsm_result rsm_fill(rsm_map *map, uint32_t face, const rsm_buffers *buffers);
/* Pixels with a value that is not finite or a negative albedo become empty and are counted.
   Errors   RSM_ERR_ARGUMENT (NULL, face, stride, neither positions nor depth), RSM_ERR_ORDER (finished),
            RSM_ERR_CANCELLED: the face is then empty */

typedef struct rsm_mesh {
    const float    *positions;      /* x, y, z of each vertex */
    size_t          vertex_count;
    size_t          vertex_stride;  /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const uint32_t *indices;        /* three to a triangle; NULL = 0, 1, 2, ... */
    size_t          index_count;    /* a multiple of 3 (ignored without indices: vertex_count is used) */
    const float    *transform;      /* object to world, affine (the last row is taken for 0 0 0 1); NULL = none */
    float           albedo[3];      /* linear, 0..1 (more is not refused), where surface_fn is NULL */
    uint32_t        material;       /* of its texels */
    int             has_holes;      /* not 0: surface_fn is asked for every pixel drawn, else for the visible ones */
    int           (*surface_fn)(void *user, const struct rsm_mesh *mesh, uint32_t triangle, const float weights[3],
                                float albedo[3]);
    /* Linear albedo at a point of a triangle, by weights of its corners; returns 0 for a hole. Called on any thread. */
    void           *user;
    uint32_t        taps;           /* surface_fn is averaged over taps x taps points of a texel: textures finer than
                                       texels neither flicker nor lose energy. 1..16, 0 = 1 */
} rsm_mesh;

RSM_DEF rsm_result rsm_rasterize(rsm_map *map, const rsm_mesh *meshes, size_t mesh_count);
/* Draws triangles into all faces, both sides, normals of the faces turned towards the light. Replaces what was there.
   Degenerate triangles and ones with a vertex not finite are skipped and counted.
   Errors   RSM_ERR_ARGUMENT, RSM_ERR_INPUT (index, counts), RSM_ERR_LIMIT (2^32 triangles), RSM_ERR_ALLOC,
            RSM_ERR_CANCELLED; the map is then empty where it was one of the last two, else as it was
   Cost     scratch of 8 bytes a triangle and 4 a texel of one face */

typedef struct rsm_stats {
    uint64_t lit_texels;            /* with flux */
    uint64_t bad_texels;            /* not finite, negative or above 1e18: empty */
    uint64_t skipped_triangles;
    double   incident[3];           /* flux that falls on texels with a surface */
    double   reflected[3];          /* sum of flux */
} rsm_stats;

RSM_DEF rsm_result rsm_finish(rsm_map *map, rsm_stats *stats);
/* Ends filling; the map may be used from then on. stats may be NULL. */

/* ---- direct light by the same map ---- */

typedef struct rsm_points {         /* strides in bytes, multiples of 4; 0 = 12 (occlusion 4) */
    size_t          count;
    const float    *positions;      size_t position_stride;    /* world */
    const float    *normals;        size_t normal_stride;      /* unit, not made so; 0 0 0: no receiver, result 0 */
    const float    *occlusion;      size_t occlusion_stride;   /* factor of each result, 0..1; NULL = 1 */
    uint32_t        width;          /* of the picture that the points are, row by row; 0 = no picture */
    const uint32_t *indices;        /* only these points, each once; count is their number then; NULL = all */
    size_t          index_count;
} rsm_points;

typedef struct rsm_direct_desc {
    uint32_t   taps;                /* percentage-closer filter: taps x taps texels, 1..15; 0 = 2, bilinear */
    float      bias;                /* texels, towards the light; >= 0. 0 really is none */
    float      slope_bias;          /* times what a plane of this slope, up to 10, needs to clear all taps; >= 0 */
    int        add;                 /* not 0: results are added to what is there */
    rsm_system system;
} rsm_direct_desc;

RSM_DEF rsm_direct_desc rsm_direct_default(void);     /* taps 2, bias 0.5, slope_bias 1 */

RSM_DEF rsm_result rsm_direct(const rsm_map *map, const rsm_direct_desc *desc, const rsm_points *points,
                              float *irradiance);
/* Irradiance of the light itself, shadowed by the map: 3 floats a point, indexed as the points. occlusion is not used.
   Points that are outside the map or not finite: outside is lit by a sun, dark otherwise. */

/* ---- bounced light ---- */

typedef enum rsm_pattern {
    RSM_PATTERN_DEFAULT,            /* = RSM_PATTERN_FLUX */
    RSM_PATTERN_FLUX,               /* texels in proportion to flux, the same for all receivers */
    RSM_PATTERN_EQUATION3,          /* the paper's: about the receiver's projection, density 1/r */
    RSM_PATTERN_LOG_RADIAL,         /* density 1/r^2 from r_min out, a uniform disc inside it */
    RSM_PATTERN_POISSON,            /* uniform disc with a least distance; 4096 samples at most */
    RSM_PATTERN_LOW_DISCREPANCY,    /* uniform disc, a (0, 2)-sequence */
    RSM_PATTERN_MIXED,              /* two fifths FLUX, three LOG_RADIAL with r_min 1/192, by multiple importance
                                       sampling: least error in corners, slower. r_max and r_min are not used */
    RSM_PATTERN_COUNT
} rsm_pattern;

typedef struct rsm_material {       /* Phong lobe beside the diffuse flux, energy bounded by specular */
    float specular[3];              /* 0..1 */
    float exponent;                 /* 0..1e4 */
} rsm_material;

typedef struct rsm_gather_desc {
    rsm_pattern pattern;
    uint32_t    samples;            /* of each receiver and map, 1..2^20; 0 = every texel, whatever the pattern */
    int         paper_weights;      /* EQUATION3: not 0: xi^2, normalised, as the paper has it; biased */
    float       r_max;              /* radius of the pattern in sides of the map; above 0: samples outside the map count
                                       as dark, and what lies beyond is lost. 0: each ray ends at the map's border.
                                       Cubes: sine of half the angle, 1 = all round */
    float       r_min;              /* LOG_RADIAL: share of the radius, below 1; 0 = 1/32 */
    float       offset;             /* world units: pixel lights move along -normal; >= 0 (section 3.2) */
    float       clamp;              /* bound on cos cos / d^2, 1 / unit^2; 0 = none */
    float       near_limit;         /* bound on a light's irradiance, in its own radiosity (1 is what an infinite wall
                                       gives); 0 = none. Uses texel areas x weights */
    uint32_t    seed;               /* another seed, another choice of samples: each frame, before a filter */
    const float *noise;             /* noise_side^2 floats in 0..1, tiled over the picture: turns the pattern of each
                                       pixel (not FLUX). rsm_blue_noise makes one */
    uint32_t    noise_side;
    uint32_t    interleave;         /* k: pixel (x, y) takes set x % k + k (y % k) of k k sets that share the samples;
                                       1, 2, 4, 8; 0 = 1. Pictures alone: above 1 points->width must not be 0.
                                       rsm_filter_apply with log2 k passes puts them together */
    const rsm_material *materials;  /* NULL: all diffuse. Texels with material m use materials[m - 1]. FLUX picks by
                                       diffuse flux: with samples, black texels' lobes take a pattern about the
                                       receiver */
    uint32_t    material_count;
    int         add;                /* not 0: results are added to what is there: several lists, light maps */
    rsm_system  system;
    float       near_field;         /* texels nearer than this times their side, the root of their area, are no points
                                       but the parallelograms of surface that they are, by their form factors: 3 does. 0
                                       = none, 32 at most. Of every texel (samples 0) and of patterns about the
                                       receiver; not of lights by flux, nor of lists. Moved by offset, bounded by
                                       near_limit and clamp as points are; lobes as at their centre */
} rsm_gather_desc;

typedef struct rsm_gather_stats {
    uint64_t evaluated;             /* receivers that were gathered for */
    uint64_t pairs;                 /* of receiver and pixel light */
    uint64_t bad_points;            /* not finite or beyond 1e9: result 0 */
    double   clamped_share;         /* light lost by clamp and near_limit / light without them, channels together */
    double   outside_share;         /* flux beyond r_max, mean over receivers (64 of them are looked at) */
} rsm_gather_stats;

RSM_DEF rsm_result rsm_gather(const rsm_map *const *maps, size_t map_count, const rsm_gather_desc *desc,
                              const rsm_points *points, float *irradiance, rsm_gather_stats *stats);
/* Irradiance from all maps' texels: 3 floats a point, indexed as the points. stats may be NULL; with it a clamp costs a
   fifth more. Nothing is written where the result is not RSM_OK, but RSM_ERR_CANCELLED may leave some points done.
   Errors   RSM_ERR_ARGUMENT, RSM_ERR_DESC, RSM_ERR_ORDER (a map is not finished), RSM_ERR_ALLOC, RSM_ERR_CANCELLED
   Cost     receivers x maps x samples, about 1 ns a pair (FLUX), 20 ns (patterns about the receiver) */

RSM_DEF rsm_result rsm_gather_list(const rsm_texel *lights, size_t count, const rsm_gather_desc *desc,
                                   const rsm_points *points, float *irradiance, rsm_gather_stats *stats);
/* The same from a list of pixel lights of any origin. pattern, samples, r_max, seed, noise and materials are not used;
   area is used by near_limit. */

RSM_DEF rsm_result rsm_pixel_lights(const rsm_map *const *maps, size_t map_count, uint32_t samples, uint32_t seed,
                                    rsm_texel *lights, size_t capacity, size_t *count);
/* Lights that stand for whole maps: samples of each in proportion to flux, flux and area scaled; 0 = every lit texel.
   count     written on RSM_OK and RSM_ERR_MEMORY: lights needed; lights may be NULL with capacity 0 to ask */

RSM_DEF rsm_result rsm_cluster(const rsm_texel *lights, size_t light_count, uint32_t cluster_count,
                               const rsm_system *system, rsm_texel *clusters, size_t *count);
/* Groups lights into at most cluster_count area lights: flux and area are sums, position and normal means by flux;
   where normals cancel out, the brightest light's.
   cluster_count  1..65536, of 2^31 - 1 lights at most
   clusters  room for cluster_count; *count of them are written, without flux none
   Errors    RSM_ERR_ARGUMENT, RSM_ERR_ALLOC (4 bytes a light, 128 a cluster). system may be NULL */

RSM_DEF rsm_result rsm_pattern_build(rsm_pattern pattern, uint32_t samples, float r_min, int paper_weights,
                                     uint32_t seed, float *points);
/* The pattern in the unit disc: x, y and weight of each sample; the mean of f over the disc is sum(weight f) / pi.
   points    3 floats each
   Errors    RSM_ERR_ARGUMENT (pattern FLUX or MIXED, samples 0 or above 2^20, POISSON above 4096, r_min not in 0..1) */

RSM_DEF rsm_result rsm_blue_noise(uint32_t side, uint32_t seed, const rsm_system *system, float *values);
/* side^2 values (i + 0.5) / side^2, each once, by void and cluster (Ulichney 1993), which tile. side 4..64: O(side^4).
   Errors    RSM_ERR_ARGUMENT, RSM_ERR_ALLOC (4 bytes a value) */

/* ---- pictures: interpolation, or few samples and a filter ---- */

typedef struct rsm_interpolation {
    uint32_t step;                  /* pixels between samples of the coarse grid, a power of two, 2..64; 0 = 8 */
    uint32_t levels;                /* grids tried, each of half the step, before pixels are evaluated one by one, at
                                       most 6; 0 = all; 1 = the paper */
    float    normal_cosine;         /* of a sample's normal against the pixel's at least this; 0 = 0.95 */
    float    plane_slope;           /* a sample lies off the pixel's plane at most this times its distance; 0 = 0.05 */
    float    distance;              /* world units, at most this far; 0 = no limit */
    float    contrast;              /* largest difference of the samples / their mean; above it the grid is refined. 0 =
                                       0.25; negative = not asked, as in the paper */
    uint8_t *mask;                  /* NULL, or one byte a pixel: 0 none, 1 interpolated, 2 evaluated */
    float    reach;                 /* a sample is good up to this times its distance from the nearest pixel light, so
                                       that no bright spot is missed between samples. 0 = 0.25; negative = not asked */
} rsm_interpolation;

RSM_DEF rsm_result rsm_interpolate(const rsm_map *const *maps, size_t map_count, const rsm_gather_desc *desc,
                                   const rsm_interpolation *interpolation, const rsm_points *points, float *irradiance,
                                   rsm_gather_stats *stats);
/* rsm_gather for a picture (points->width, no indices), most pixels by interpolation between 3 or 4 samples of a grid
   that look alike (section 4); only what is left is evaluated. stats->evaluated / pixels is the share that was.
   desc->noise and interleave must be off, and add too: RSM_ERR_DESC. interpolation may be NULL. */

typedef struct rsm_filter rsm_filter;

RSM_DEF rsm_result rsm_filter_create(uint32_t width, uint32_t height, const rsm_system *system, rsm_filter **out);
RSM_DEF void       rsm_filter_free(rsm_filter *filter);      /* accepts NULL */
RSM_DEF void       rsm_filter_reset(rsm_filter *filter);     /* forgets the frames before */

typedef struct rsm_filter_desc {
    const float *view_projection;   /* world to clip of this frame, for the next one; NULL: neither is reprojected, the
                                       frame starts anew */
    const float *motion;            /* NULL, or where each pixel's surface was: x, y in pixels of the last frame */
    int      top_first;             /* not 0: row 0 is the top of the picture, at clip y = +1; 0: its bottom */
    uint32_t history;               /* frames that count at most: a static light reaches 1 / history of the noise's
                                       variance, a moving one lags by as many. 0 = 8; 1 = none */
    uint32_t passes;                /* a-trous passes over neighbours, steps 1, 2, 4, ..; 0 = none .. 6 */
    float    normal_cosine;         /* 0 = 0.9 */
    float    plane_slope;           /* 0 = 0.1 */
} rsm_filter_desc;

RSM_DEF rsm_result rsm_filter_apply(rsm_filter *filter, const rsm_filter_desc *desc, const rsm_points *points,
                                    const float *irradiance, float *out);
/* Temporal accumulation with reprojection, then passes of the kernel 1 2 1 by 1 2 1 that stop at edges of normals and
   planes. Two passes average 4 x 4 interleaved sets with equal weights, three 8 x 8. A pixel with few neighbours like
   it, which nothing averages, is made no brighter than its brightest neighbour: single spots go, with them some light
   of fine geometry (docs/rsm.md, section 5).
   points    the picture: width x height receivers, no indices
   out       3 floats a pixel; may be irradiance */

#ifdef __cplusplus
}
#endif

#endif /* RSM_H */

/* ==== implementation ============================================================================================== */

#if defined(RSM_IMPLEMENTATION) && !defined(RSM_IMPLEMENTED)
#define RSM_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifdef RSM_NO_SIMD
#define RSM__NO_SIMD
#endif

/* >>> shared fp_begin mem v3 trig rng lds cpu batch: written by tools/stamp from src/shared, edit there */

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

typedef struct rsm__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} rsm__allocator;

static inline void *rsm__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void rsm__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* *out = a * b and 1, or 0 and *out untouched where the product does not fit. */
static inline int rsm__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

static inline int rsm__add_size(size_t a, size_t b, size_t *out)
{
    if (a > SIZE_MAX - b) return 0;
    *out = a + b;
    return 1;
}

/* Bytes between elements of floats that are `standard` large: 0 stands for that; else they do not overlap. */
static inline int rsm__stride_valid(size_t stride, size_t standard)
{
    return stride == 0 || (stride >= standard && stride % 4 == 0);
}

/* Takes the members of a public desc. Both functions or none: valid() is what the desc check asks. */
static inline int rsm__allocator_valid(void *(*alloc_fn)(size_t, void *), void (*free_fn)(void *, void *))
{
    return (alloc_fn == NULL) == (free_fn == NULL);
}

static inline rsm__allocator rsm__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    rsm__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : rsm__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : rsm__default_free;
    a.user = user;
    return a;
}

/* NULL where the size is 0 or overflows, so that a caller has one thing to test. */
static inline void *rsm__alloc(const rsm__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *rsm__alloc_array(const rsm__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return rsm__mul_size(count, item_size, &size) ? rsm__alloc(a, size) : NULL;
}

static inline void rsm__free(const rsm__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* unit v3: three floats */

/* tcc 0.9.27 stores a returned struct of 12 bytes as 16, over the caller's next variable. */
typedef struct rsm__v3 {
    float x, y, z;
#ifdef __TINYC__
    float unused;
#endif
} rsm__v3;

static inline rsm__v3 rsm__v3_make(float x, float y, float z)
{
    rsm__v3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

static inline rsm__v3 rsm__v3_load(const float *p) { return rsm__v3_make(p[0], p[1], p[2]); }
static inline void rsm__v3_store(float *p, rsm__v3 v) { p[0] = v.x; p[1] = v.y; p[2] = v.z; }

static inline rsm__v3 rsm__v3_sub(rsm__v3 a, rsm__v3 b)
{
    return rsm__v3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline rsm__v3 rsm__v3_scale(rsm__v3 a, float s)
{
    return rsm__v3_make(a.x * s, a.y * s, a.z * s);
}

/* a + b s */
static inline rsm__v3 rsm__v3_madd(rsm__v3 a, rsm__v3 b, float s)
{
    return rsm__v3_make(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s);
}

static inline float rsm__v3_dot(rsm__v3 a, rsm__v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float rsm__v3_length(rsm__v3 a)
{
    return sqrtf(rsm__v3_dot(a, a));
}

static inline rsm__v3 rsm__v3_cross(rsm__v3 a, rsm__v3 b)
{
    return rsm__v3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/* Scaled by the largest component first, so that neither tiny nor huge vectors leave the float range.
   The zero vector stays zero. */
static inline rsm__v3 rsm__v3_normalize(rsm__v3 a)
{
    float x = fabsf(a.x), y = fabsf(a.y), z = fabsf(a.z), m = x > y ? x : y;
    m = m > z ? m : z;
    if (!(m > 0.0f)) return rsm__v3_make(0.0f, 0.0f, 0.0f);
    if (m < 1e-30f) {
        a = rsm__v3_scale(a, 1e30f);
        m *= 1e30f;
    }
    a = rsm__v3_make(a.x / m, a.y / m, a.z / m);
    m = rsm__v3_length(a);
    return rsm__v3_make(a.x / m, a.y / m, a.z / m);
}

/* By the exponent bits, because compilers may take isfinite() for always true under -ffast-math. */
static inline int rsm__finite(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7f800000u) != 0x7f800000u;
}

static inline int rsm__v3_finite(rsm__v3 a)
{
    return rsm__finite(a.x) && rsm__finite(a.y) && rsm__finite(a.z);
}

/* b1, b2, n right-handed and orthonormal for a unit n. Duff et al., "Building an orthonormal basis, revisited",
   JCGT 6(1), 2017; n.z = -0 and n.z = -1 included. */
static inline void rsm__v3_basis(rsm__v3 n, rsm__v3 *b1, rsm__v3 *b2)
{
    float s = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + n.z), b = n.x * n.y * a;
    *b1 = rsm__v3_make(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
    *b2 = rsm__v3_make(b, s + n.y * n.y * a, -n.y);
}

/* unit trig: elementary functions with the same bits on every machine */

/* Only + - * / and sqrt, which IEEE 754 rounds the same everywhere as long as nothing is contracted (unit fp_begin).
   Coefficients are minimax fits of our own. The float functions are free of branches and calls, so that loops over
   them vectorise at SSE2 level. Errors named below are the largest against the double functions, all float arguments or
   a dense set tried (tests/unit/shared_test.c). Out of range or NaN is clamped into the range, so that nothing here is
   undefined or returns NaN. */

static inline float rsm__from_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline uint32_t rsm__to_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* |x| with the sign bit of s; s = -0 counts as negative. */
static inline float rsm__copysign(float x, float s)
{
    return rsm__from_bits((rsm__to_bits(x) & 0x7fffffffu) | (rsm__to_bits(s) & 0x80000000u));
}

/* a where yes is 1, b where it is 0, both computed: compilers turn a chain of ?: with one condition into a branch, and
   then do not vectorise the loop round it. */
static inline float rsm__either(int yes, float a, float b)
{
    uint32_t mask = 0u - (uint32_t)yes;
    return rsm__from_bits((rsm__to_bits(a) & mask) | (rsm__to_bits(b) & ~mask));
}

/* Cody and Waite: pi/2 in three parts, of which the first two times k are exact for |k| < 2^13. |x| <= 8192: error 1e-7
   absolute. */
static inline void rsm__sincos(float x, float *sine, float *cosine)
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

/* All quadrants, zeros of either sign and infinities as C's atan2f; atan2(0, 0) = 0. Error 4e-7 absolute, 3 ulp. */
static inline float rsm__atan2(float y, float x)
{
    float ax = fabsf(x), ay = fabsf(y), a, t, z, p;
    float hi = rsm__either(ax > ay, ax, ay), lo = rsm__either(ax > ay, ay, ax);
    int big;
    a = rsm__either((lo == hi) & (hi > 0.0f), 1.0f, lo / rsm__either(hi > 0.0f, hi, 1.0f));
    big = a > 0.414213562f;
    t = rsm__either(big, (a - 1.0f) / (a + 1.0f), a);
    z = t * t;
    p = t + t * z * (-0.3333295525f + z * (0.1997792608f + z * (-0.1387984996f + z * 0.08060308882f)));
    p = rsm__either(big, p + 0.785398163f, p);
    p = rsm__either(ay > ax, 1.57079633f - p, p);
    p = rsm__either((int)(rsm__to_bits(x) >> 31), 3.14159265f - p, p);
    return rsm__copysign(p, y);
}

/* 2^k (1 + r + r^2 p(r)), |r| <= ln 2 / 2, in double: exp, log and pow err by 1 ulp. */
static inline double rsm__exp_core(double x)
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
static inline double rsm__log_core(float x)
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
static inline float rsm__exp(float x)
{
    return x > 88.7228394f ? rsm__from_bits(0x7f800000u) : (float)rsm__exp_core((double)x);
}

/* -infinity where x is not above 0. */
static inline float rsm__log(float x)
{
    return x > 0.0f ? (float)rsm__log_core(x) : rsm__from_bits(0xff800000u);
}

/* x below 0 counts as 0; pow(0, y) is 0, 1 or infinity for y above, equal to or below 0. */
static inline float rsm__pow(float x, float y)
{
    double t;
    if (y == 0.0f) return 1.0f;
    if (!(x > 0.0f)) return y > 0.0f ? 0.0f : rsm__from_bits(0x7f800000u);
    t = (double)y * rsm__log_core(x);
    return t > 88.722839111 ? rsm__from_bits(0x7f800000u) : (float)rsm__exp_core(t);
}

/* unit rng: hashes and random numbers, the same on every machine */

/* Jarzynski and Olano, "Hash functions for GPU rendering", JCGT 9(3), 2020: the output function of O'Neill's PCG. */
static inline uint32_t rsm__hash32(uint32_t x)
{
    uint32_t state = x * 747796405u + 2891336453u;
    uint32_t word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

static inline uint32_t rsm__hash_combine(uint32_t a, uint32_t b)
{
    return rsm__hash32(a + 0x9e3779b9u * rsm__hash32(b));
}

/* The upper 24 bits: every value is a float, the largest is 1 - 2^-24. */
static inline float rsm__to_unit(uint32_t bits) { return (float)(bits >> 8) * (1.0f / 16777216.0f); }

/* Number i of the stream (seed, stream), in [0, 1), without state: what threads and tiles need. */
static inline float rsm__random(uint32_t seed, uint32_t stream, uint32_t i)
{
    return rsm__to_unit(rsm__hash_combine(rsm__hash_combine(seed, stream), i));
}

/* unit lds, needs rng: low-discrepancy points in [0, 1) */

static inline uint32_t rsm__reverse_bits(uint32_t x)
{
    x = x >> 16 | x << 16;
    x = (x >> 8 & 0x00ff00ffu) | (x & 0x00ff00ffu) << 8;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    return (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
}

/* Owen scrambling by the hash of Laine and Karras as Burley tuned it, "Practical hash-based Owen scrambling",
   JCGT 9(4), 2020. Works on reversed bits: a bit depends on the more significant ones only. */
static inline uint32_t rsm__owen(uint32_t x, uint32_t seed)
{
    x = rsm__reverse_bits(x) + seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return rsm__reverse_bits(x);
}

/* Point i of a scrambled (0, 2)-sequence: the first two dimensions of Sobol's. The order is shuffled too, so that
   different seeds may be combined to more dimensions. */
static inline void rsm__sobol2(uint32_t i, uint32_t seed, float *u, float *v)
{
    uint32_t x, y = 0, d = 0x80000000u, k;
    i = rsm__owen(i, rsm__hash32(seed));
    x = rsm__reverse_bits(i);
    for (k = i; k; k >>= 1, d ^= d >> 1)
        if (k & 1u) y ^= d;
    *u = rsm__to_unit(rsm__owen(x, rsm__hash_combine(seed, 1u)));
    *v = rsm__to_unit(rsm__owen(y, rsm__hash_combine(seed, 2u)));
}

/* unit cpu: run-time detection of x86 vector units */

/* RSM__X86 is 1 where functions with target attributes can be compiled and chosen at run time.
   RSM__NO_SIMD, defined by the header from its public switch, leaves all of it out. tcc has no attributes; MSVC
   needs none. clang in MSVC's place (clang-cl) hides the vector types unless all is built for them. */
#if !defined(RSM__NO_SIMD) && (defined(__x86_64__) || defined(__i386__)) && defined(__GNUC__) && !defined(__TINYC__)
#define RSM__X86 1
#define RSM__TARGET_AVX2 __attribute__((target("avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#define RSM__TARGET_AVX512 \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#elif !defined(RSM__NO_SIMD) && defined(_MSC_VER) && defined(_M_X64) && !defined(__clang__)
#define RSM__X86 1
#define RSM__TARGET_AVX2
#define RSM__TARGET_AVX512
#else
#define RSM__X86 0
#endif

#if RSM__X86 && defined(_MSC_VER)
#include <intrin.h>
/* Bit of leaf 7's ebx, after FMA and what the operating system saves were checked. */
static inline int rsm__cpu_leaf7(unsigned xcr0, unsigned ebx)
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
static inline int rsm__cpu_has_avx2(void) { return rsm__cpu_leaf7(0x06u, 0x00000128u); }
static inline int rsm__cpu_has_avx512(void) { return rsm__cpu_leaf7(0xe6u, 0xc0030128u); }
#elif RSM__X86
/* The compiler's run time asks the operating system too. Every processor with BMI2 has LZCNT. */
static inline int rsm__cpu_has_avx2(void)
{
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
           __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
}
static inline int rsm__cpu_has_avx512(void)
{
    return rsm__cpu_has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}
#else
static inline int rsm__cpu_has_avx2(void) { return 0; }
static inline int rsm__cpu_has_avx512(void) { return 0; }
#endif

/* unit batch: tasks of a call, some at a time */

typedef struct rsm__batch { void (*task)(void *context, size_t index); void *context; size_t first; } rsm__batch;

/* A task itself; context: the batch. */
static inline void rsm__batch_task(void *context, size_t index)
{
    const rsm__batch *b = (const rsm__batch *)context;
    b->task(b->context, b->first + index);
}

/* <<< shared */

#define RSM__PI 3.14159265f
#define RSM__MAX_FLOAT 3.40282347e38f

enum {
    RSM__LANES = 8,          /* pixel lights that the kernel takes at once */
    RSM__SPAN = 64,          /* pixels of a row that the filter takes at once */
    RSM__WIDE = 16,          /* lanes of the widest vectors */
    RSM__BLOCK = 64,         /* of them in one block of arrays */
    RSM__RUN = 1024,         /* of them in one sum */
    RSM__BATCH = 32,         /* receivers of a task */
    RSM__FEW = 128,          /* pixel lights, at most, that go one by one to RSM__LANES receivers */
    RSM__MAX_SIZE = 4096,
    RSM__MAX_SAMPLES = 1 << 20,
    RSM__MAX_POISSON = 4096
};

/* ---- >>arguments: strides, systems, points ---- */

static inline size_t rsm__stride(size_t stride, size_t standard) { return stride ? stride : standard; }

static inline const float *rsm__at(const float *base, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)(const void *)base + i * stride);
}

/* Finite and not beyond what squares and fourth powers of floats can hold. */
static inline int rsm__usable(rsm__v3 v)
{
    return fabsf(v.x) <= 1e9f && fabsf(v.y) <= 1e9f && fabsf(v.z) <= 1e9f;      /* false for NaN */
}

static inline int rsm__system_valid(const rsm_system *s)
{
    return rsm__allocator_valid(s->allocator.alloc_fn, s->allocator.free_fn);
}

static inline rsm__allocator rsm__allocator_of(const rsm_system *s)
{
    return rsm__allocator_make(s->allocator.alloc_fn, s->allocator.free_fn, s->allocator.user);
}

static inline void rsm__run(const rsm_system *s, size_t count, rsm_task task, void *context)
{
    size_t i;
    if (s->parallel_for) s->parallel_for(s->parallel_user, count, task, context);
    else
        for (i = 0; i < count; i++) task(context, i);
}

static inline int rsm__cancelled(const rsm_system *s, float fraction)
{
    return s->progress && s->progress(s->progress_user, fraction) != 0;
}

/* The same in steps, between which the caller may cancel. begin..end: what of the whole this is. 0: cancelled. */
static inline int rsm__run_steps(const rsm_system *s, size_t count, rsm_task task, void *context, float begin,
                                 float end)
{
    size_t step, steps = s->progress ? 16 : 1;
    rsm__batch batch;
    batch.task = task;
    batch.context = context;
    batch.first = 0;
    for (step = 0; step < steps; step++) {
        size_t next = count / steps * (step + 1) + count % steps * (step + 1) / steps;
        if (rsm__cancelled(s, begin + (end - begin) * (float)step / (float)steps)) return 0;
        rsm__run(s, next - batch.first, rsm__batch_task, &batch);
        batch.first = next;
    }
    return 1;
}

static inline int rsm__points_valid(const rsm_points *p)
{
    size_t i, size;
    if (!p || (p->count && (!p->positions || !p->normals))) return 0;
    if (!rsm__stride_valid(p->position_stride, 12) || !rsm__stride_valid(p->normal_stride, 12)) return 0;
    if (!rsm__stride_valid(p->occlusion_stride, 4)) return 0;
    if (!rsm__mul_size(p->count, 12, &size)) return 0;
    if (p->indices)
        for (i = 0; i < p->index_count; i++)
            if (p->indices[i] >= p->count) return 0;
    return 1;
}

/* Receiver i: 0 where there is none; *bad counts the ones that are not finite. */
static inline int rsm__receiver(const rsm_points *p, size_t i, rsm__v3 *x, rsm__v3 *n, uint64_t *bad)
{
    *x = rsm__v3_load(rsm__at(p->positions, rsm__stride(p->position_stride, 12), i));
    *n = rsm__v3_load(rsm__at(p->normals, rsm__stride(p->normal_stride, 12), i));
    if (n->x == 0.0f && n->y == 0.0f && n->z == 0.0f) return 0;
    if (rsm__usable(*x) && rsm__usable(*n)) return 1;
    ++*bad;
    return 0;
}

static inline float rsm__mean3(const float *rgb) { return (rgb[0] + rgb[1] + rgb[2]) * (1.0f / 3.0f); }
static inline float rsm__fraction(float x) { return x - floorf(x); }

/* ---- >>map: frames of faces, projection, matrices ---- */

struct rsm_map {
    rsm_desc   desc;               /* defaults filled in */
    uint32_t   size, faces, room;  /* room: faces that its memory holds */
    int        finished, owned;
    rsm__v3    right, up, axis;    /* of face 0; the light travels along axis */
    float      extent;             /* sun: radius; others: tangent of half the face's angle */
    float      cos_half;           /* spot: of half the cone */
    rsm_stats  stats;
    rsm_texel *texels;
    double    *rows;               /* size * faces + 1 running sums of flux */
    double    *sums;               /* in each row, flux up to and including the texel */
};

static inline size_t rsm__texel_count(const rsm_map *map) { return (size_t)map->size * map->size * map->faces; }

static inline int rsm__is_sun(const rsm_map *map) { return map->desc.light.kind == RSM_LIGHT_SUN; }

/* Directions of a face: the cube of a patch looks out of its front and to its four sides. */
static inline void rsm__face_frame(const rsm_map *map, uint32_t face, rsm__v3 *r, rsm__v3 *u, rsm__v3 *a)
{
    rsm__v3 right = map->right, up = map->up, axis = map->axis;
    *r = right;
    *u = up;
    *a = axis;
    switch (face) {
    case 1: *r = rsm__v3_scale(axis, -1); *a = right; break;
    case 2: *r = axis; *a = rsm__v3_scale(right, -1); break;
    case 3: *u = rsm__v3_scale(axis, -1); *a = up; break;
    case 4: *u = axis; *a = rsm__v3_scale(up, -1); break;
    case 5: *r = rsm__v3_scale(right, -1); *a = rsm__v3_scale(axis, -1); break;
    default: break;
    }
}

static inline rsm_result rsm__light_check(rsm_light *l)
{
    rsm__v3 d = rsm__v3_load(l->direction), up = rsm__v3_load(l->up);
    int i, directed = l->kind != RSM_LIGHT_POINT;
    if ((int)l->kind < 0 || l->kind >= RSM_LIGHT_KIND_COUNT) return RSM_ERR_DESC;
    if (l->kind == RSM_LIGHT_DEFAULT) l->kind = RSM_LIGHT_SUN;
    if (!rsm__usable(rsm__v3_load(l->position)) || !rsm__v3_finite(d) || !rsm__v3_finite(up)) return RSM_ERR_DESC;
    if (directed && fabsf(rsm__v3_length(d) - 1.0f) > 1e-3f) return RSM_ERR_DESC;
    for (i = 0; i < 3; i++)
        if (!(l->value[i] >= 0.0f && l->value[i] <= 1e12f)) return RSM_ERR_DESC;
    if (l->kind == RSM_LIGHT_SUN && !(l->radius > 0.0f && l->radius <= 1e9f)) return RSM_ERR_DESC;
    if (l->kind == RSM_LIGHT_SPOT && !(l->cone_angle > 1e-3f && l->cone_angle <= 6.28f)) return RSM_ERR_DESC;
    if (l->kind == RSM_LIGHT_SQUARE_SPOT && !(l->cone_angle > 1e-3f && l->cone_angle <= 2.0f)) return RSM_ERR_DESC;
    if (l->near_depth == 0.0f && l->far_depth == 0.0f) {
        l->near_depth = l->kind == RSM_LIGHT_SUN ? -l->radius : 1e-3f;
        l->far_depth = l->kind == RSM_LIGHT_SUN ? l->radius : 1e3f;
    }
    if (!(l->near_depth < l->far_depth) || !(fabsf(l->near_depth) <= 1e9f) || !(l->far_depth <= 1e9f))
        return RSM_ERR_DESC;
    if (l->kind != RSM_LIGHT_SUN && !(l->near_depth > 0.0f)) return RSM_ERR_DESC;
    return RSM_OK;
}

/* Copies the desc into the map with its defaults. Nothing else of the map is touched on an error. */
static inline rsm_result rsm__map_set(rsm_map *map, const rsm_desc *desc)
{
    rsm_desc d = *desc;
    rsm__v3 up;
    int cube;
    rsm_result result = rsm__light_check(&d.light);
    if (result != RSM_OK) return result;
    if (!rsm__system_valid(&d.system)) return RSM_ERR_DESC;
    if (d.size != 0 && (d.size < 4 || d.size > RSM__MAX_SIZE)) return RSM_ERR_DESC;
    cube = d.light.kind == RSM_LIGHT_POINT || d.light.kind == RSM_LIGHT_PATCH ||
           (d.light.kind == RSM_LIGHT_SPOT && d.light.cone_angle > 2.0f);
    if (d.size == 0) d.size = cube ? 256 : 512;
    map->faces = !cube ? 1 : d.light.kind == RSM_LIGHT_PATCH ? 5 : 6;
    map->size = d.size;
    map->desc = d;
    map->axis =
        d.light.kind == RSM_LIGHT_POINT ? rsm__v3_make(0, 0, -1) : rsm__v3_normalize(rsm__v3_load(d.light.direction));
    if (d.light.kind == RSM_LIGHT_SUN) map->axis = rsm__v3_scale(map->axis, -1);
    up = rsm__v3_normalize(d.light.kind == RSM_LIGHT_POINT ? rsm__v3_make(0, 1, 0) : rsm__v3_load(d.light.up));
    if (rsm__v3_length(rsm__v3_cross(map->axis, up)) < 1e-3f)
        up = fabsf(map->axis.y) < 0.9f ? rsm__v3_make(0, 1, 0) : rsm__v3_make(0, 0, 1);
    map->right = rsm__v3_normalize(rsm__v3_cross(map->axis, up));
    map->up = rsm__v3_cross(map->right, map->axis);
    map->extent = 1.0f;
    map->cos_half = -1.0f;
    if (d.light.kind == RSM_LIGHT_SUN) map->extent = d.light.radius;
    else if (d.light.kind == RSM_LIGHT_SPOT || d.light.kind == RSM_LIGHT_SQUARE_SPOT) {
        float s, c;
        rsm__sincos(0.5f * d.light.cone_angle, &s, &c);
        if (!cube) map->extent = s / c;
        if (d.light.kind == RSM_LIGHT_SPOT) map->cos_half = c;
    }
    return RSM_OK;
}

/* In a face's frame: x and y in units of its half side, z the depth. */
static inline rsm__v3 rsm__to_face(const rsm_map *map, uint32_t face, rsm__v3 p)
{
    rsm__v3 r, u, a, q = rsm__v3_sub(p, rsm__v3_load(map->desc.light.position));
    float z, scale;
    rsm__face_frame(map, face, &r, &u, &a);
    z = rsm__v3_dot(q, a);
    scale = rsm__is_sun(map) ? 1.0f / map->extent : 1.0f / (map->extent * z);
    return rsm__v3_make(rsm__v3_dot(q, r) * scale, rsm__v3_dot(q, u) * scale, z);
}

/* The point at depth z under (x, y) of a face, both -1..1. */
static inline rsm__v3 rsm__from_face(const rsm_map *map, uint32_t face, float x, float y, float z)
{
    rsm__v3 r, u, a, p = rsm__v3_load(map->desc.light.position);
    float scale = rsm__is_sun(map) ? map->extent : map->extent * z;
    rsm__face_frame(map, face, &r, &u, &a);
    p = rsm__v3_madd(p, r, x * scale);
    p = rsm__v3_madd(p, u, y * scale);
    return rsm__v3_madd(p, a, z);
}

/* The face that a direction in the light's frame (right, up, axis) leaves the cube by. */
static inline uint32_t rsm__cube_face(float x, float y, float z)
{
    float ax = fabsf(x), ay = fabsf(y), az = fabsf(z);
    if (az >= ax && az >= ay) return z >= 0.0f ? 0 : 5;
    if (ax >= ay) return x >= 0.0f ? 1 : 2;
    return y >= 0.0f ? 3 : 4;
}

static inline uint32_t rsm__face_of(const rsm_map *map, rsm__v3 p)
{
    rsm__v3 q = rsm__v3_sub(p, rsm__v3_load(map->desc.light.position));
    if (map->faces == 1) return 0;
    return rsm__cube_face(rsm__v3_dot(q, map->right), rsm__v3_dot(q, map->up), rsm__v3_dot(q, map->axis));
}

static inline float rsm__texel_centre(const rsm_map *map, uint32_t i)
{
    return ((float)i + 0.5f) * 2.0f / (float)map->size - 1.0f;
}

/* Unit, from a point of the scene to the light. */
static inline rsm__v3 rsm__to_light(const rsm_map *map, rsm__v3 p)
{
    if (rsm__is_sun(map)) return rsm__v3_scale(map->axis, -1);
    return rsm__v3_normalize(rsm__v3_sub(rsm__v3_load(map->desc.light.position), p));
}

/* ---- >>flux: light through a texel ---- */

/* Flux for a light of value 1 through the part (x, y) +- h of a face, in its plane at distance 1: the integral of
   cos^3 by Gauss points, two an axis where texels are small and four else, which is exact to 1e-6 and free of the
   cancellation of the arctangent form. A patch adds the cosine to its normal. The cone's rim is cut
   by rsm__incident. */
static inline float rsm__solid_angle(const rsm_map *map, rsm__v3 r, rsm__v3 u, rsm__v3 a, float x, float y, float h)
{
    static const float node[6] = {
        -0.577350269f, 0.577350269f, -0.861136312f, -0.339981044f, 0.339981044f, 0.861136312f
    };
    static const float weight[6] = { 0.5f, 0.5f, 0.173927423f, 0.326072577f, 0.326072577f, 0.173927423f };
    float sum = 0.0f;
    int i, j, first = h < 0.05f ? 0 : 2, end = h < 0.05f ? 2 : 6;
    for (j = first; j < end; j++)
        for (i = first; i < end; i++) {
            float s = x + h * node[i], t = y + h * node[j], q = 1.0f / (1.0f + s * s + t * t);
            float f = q * sqrtf(q);
            if (map->desc.light.kind == RSM_LIGHT_PATCH) {
                float c = rsm__v3_dot(map->axis, rsm__v3_madd(rsm__v3_madd(a, r, s), u, t)) * sqrtf(q);
                f = c > 0.0f ? f * c : 0.0f;
            }
            sum += f * weight[i] * weight[j];
        }
    return sum * 4.0f * h * h;
}

static inline int rsm__in_cone(const rsm_map *map, rsm__v3 r, rsm__v3 u, rsm__v3 a, float x, float y)
{
    rsm__v3 d = rsm__v3_madd(rsm__v3_madd(a, r, x), u, y);
    return rsm__v3_dot(map->axis, d) >= map->cos_half * rsm__v3_length(d);
}

static inline float rsm__incident(const rsm_map *map, uint32_t face, uint32_t i, uint32_t j)
{
    rsm__v3 r, u, a;
    float h = map->extent / (float)map->size, x = rsm__texel_centre(map, i) * map->extent;
    float y = rsm__texel_centre(map, j) * map->extent, flux;
    int k, l, corners = 0, covered = 0;
    if (rsm__is_sun(map)) return 4.0f * h * h;
    rsm__face_frame(map, face, &r, &u, &a);
    flux = rsm__solid_angle(map, r, u, a, x, y, h);
    if (map->desc.light.kind != RSM_LIGHT_SPOT) return flux;
    for (k = 0; k < 4; k++) corners += rsm__in_cone(map, r, u, a, x + (k & 1 ? h : -h), y + (k & 2 ? h : -h));
    if (corners == 4) return flux;
    if (corners == 0 && !rsm__in_cone(map, r, u, a, x, y)) return 0.0f;
    for (l = 0; l < 8; l++)
        for (k = 0; k < 8; k++)
            covered += rsm__in_cone(map, r, u, a, x + h * ((float)k - 3.5f) * 0.25f, y + h * ((float)l - 3.5f) * 0.25f);
    return flux * (float)covered * (1.0f / 64.0f);
}

static inline void rsm__texel_clear(rsm_texel *t)
{
    memset(t, 0, sizeof *t);
    t->depth = RSM_FAR;
}

/* One texel from what a renderer knows of it. */
static inline void rsm__texel_set(rsm_map *map, uint32_t face, uint32_t i, uint32_t j, rsm__v3 position, rsm__v3 normal,
                                  const float albedo[3], uint32_t material)
{
    rsm_texel *t = map->texels + ((size_t)face * map->size + j) * map->size + i;
    rsm__v3 q = rsm__to_face(map, face, position);
    float incident = rsm__incident(map, face, i, j), slope, distance;
    int c, bad;
    normal = rsm__v3_normalize(normal);
    bad = !rsm__usable(position) || !rsm__v3_finite(normal) || !rsm__finite(q.z);
    for (c = 0; c < 3; c++) bad |= !(albedo[c] >= 0.0f && albedo[c] * incident * map->desc.light.value[c] <= 1e18f);
    rsm__texel_clear(t);
    if (bad) {
        t->material = UINT32_MAX;                /* counted by rsm_finish */
        return;
    }
    rsm__v3_store(t->position, position);
    rsm__v3_store(t->normal, normal);
    t->depth = q.z;
    t->material = material == UINT32_MAX ? 0 : material;
    for (c = 0; c < 3; c++) t->flux[c] = incident * map->desc.light.value[c] * albedo[c];
    /* Surface under the texel: the cross section of its beam over the cosine, grazing ones bounded. */
    slope = fabsf(rsm__v3_dot(normal, rsm__to_light(map, position)));
    distance = rsm__is_sun(map) ? 1.0f : q.z * map->extent;
    t->area = 4.0f * distance * distance / ((float)map->size * (float)map->size) *
              (rsm__is_sun(map) ? map->extent * map->extent : 1.0f);
    if (!rsm__is_sun(map)) {                     /* a face's plane cuts the beam at an angle */
        rsm__v3 r, u, a;
        rsm__face_frame(map, face, &r, &u, &a);
        t->area *= fabsf(rsm__v3_dot(a, rsm__to_light(map, position)));
    }
    t->area /= slope > 0.05f ? slope : 0.05f;
}

/* Running sums of flux, in double. A texel that is counted bad becomes empty here. */
static inline void rsm__sum_flux(rsm_map *map, int want_incident)
{
    size_t i, at = 0, rows = (size_t)map->size * map->faces, row;
    double total = 0.0;
    map->stats.lit_texels = map->stats.bad_texels = 0;
    for (i = 0; i < 3; i++) map->stats.incident[i] = map->stats.reflected[i] = 0.0;
    for (row = 0; row < rows; row++) {
        double sum = 0.0;
        map->rows[row] = total;
        for (i = 0; i < map->size; i++, at++) {
            rsm_texel *t = map->texels + at;
            int c;
            if (t->material == UINT32_MAX) {
                t->material = 0;
                map->stats.bad_texels++;
            }
            if (t->depth < RSM_FAR) {
                float f = !want_incident ? 0.0f : rsm__incident(map, (uint32_t)(row / map->size), (uint32_t)i,
                                                                (uint32_t)(row % map->size));
                for (c = 0; c < 3; c++) {
                    map->stats.incident[c] += (double)(f * map->desc.light.value[c]);
                    map->stats.reflected[c] += (double)t->flux[c];
                }
            }
            sum += (double)rsm__mean3(t->flux);
            map->stats.lit_texels += rsm__mean3(t->flux) > 0.0f;
            map->sums[at] = sum;
        }
        total += sum;
    }
    map->rows[rows] = total;
}

/* ---- >>raster: triangles into a face ---- */

/* Homogeneous edge functions (Olano and Greer 1997): with corners (x, y, w), w the depth in a perspective face and 1
   for a sun, the ray (X, Y, 1) meets the triangle where three determinants have one sign; their shares are the weights
   of the corners. Nothing is clipped. In double, from the same floats on both sides of a shared edge: no cracks. */
typedef struct rsm__corner { double x, y, w, z; } rsm__corner;

typedef struct rsm__box { uint16_t x0, y0, x1, y1; } rsm__box;    /* inclusive; x0 > x1: nothing */

typedef struct rsm__raster {
    rsm_map        *map;
    const rsm_mesh *meshes;
    size_t          mesh_count, triangles;
    uint32_t        face;
    rsm__box       *boxes;         /* of each triangle on this face */
    uint32_t       *winners;       /* of each texel, triangle + 1 */
    rsm__v3         right, up, axis;
} rsm__raster;

enum { RSM__CHUNK = 4096, RSM__BAND = 16 };

static inline size_t rsm__mesh_triangles(const rsm_mesh *m)
{
    return (m->indices ? m->index_count : m->vertex_count) / 3;
}

static inline rsm__v3 rsm__mesh_corner(const rsm_mesh *m, size_t triangle, int k)
{
    size_t i = 3 * triangle + (size_t)k;
    const float *p, *t = m->transform;
    if (m->indices) i = m->indices[i];
    p = rsm__at(m->positions, rsm__stride(m->vertex_stride, 12), i);
    if (!t) return rsm__v3_load(p);
    return rsm__v3_make(t[0] * p[0] + t[4] * p[1] + t[8] * p[2] + t[12],
                        t[1] * p[0] + t[5] * p[1] + t[9] * p[2] + t[13],
                        t[2] * p[0] + t[6] * p[1] + t[10] * p[2] + t[14]);
}

/* Mesh and triangle of a running number. */
static inline const rsm_mesh *rsm__mesh_of(const rsm__raster *r, size_t number, size_t *triangle)
{
    const rsm_mesh *m = r->meshes;
    while (number >= rsm__mesh_triangles(m)) number -= rsm__mesh_triangles(m++);
    *triangle = number;
    return m;
}

static inline rsm__corner rsm__project_corner(const rsm__raster *r, rsm__v3 p)
{
    const float *o = r->map->desc.light.position;
    double x = (double)p.x - (double)o[0], y = (double)p.y - (double)o[1], z = (double)p.z - (double)o[2];
    double e = (double)r->map->extent;
    rsm__corner c;
    c.x = x * (double)r->right.x + y * (double)r->right.y + z * (double)r->right.z;
    c.y = x * (double)r->up.x + y * (double)r->up.y + z * (double)r->up.z;
    c.z = x * (double)r->axis.x + y * (double)r->axis.y + z * (double)r->axis.z;
    c.w = 1.0;
    if (rsm__is_sun(r->map)) {
        c.x /= e;
        c.y /= e;
    } else c.w = c.z * e;
    return c;
}

static inline void rsm__widen(double box[4], double x, double y)
{
    if (x < box[0]) box[0] = x;
    if (y < box[1]) box[1] = y;
    if (x > box[2]) box[2] = x;
    if (y > box[3]) box[3] = y;
}

/* Texels whose centres may lie in the triangle. Corners before the near plane count where their edges cross it. */
static inline rsm__box rsm__bound(const rsm__raster *r, const rsm__corner c[3])
{
    double box[4] = { 1e30, 1e30, -1e30, -1e30 }, near_z = (double)r->map->desc.light.near_depth, size = r->map->size;
    rsm__box out = { 1, 0, 0, 0 };
    int k;
    if (rsm__is_sun(r->map)) {
        for (k = 0; k < 3; k++) rsm__widen(box, c[k].x, c[k].y);
    } else
        for (k = 0; k < 3; k++) {
            const rsm__corner *p = &c[k], *q = &c[(k + 1) % 3];
            if (p->z >= near_z) rsm__widen(box, p->x / p->w, p->y / p->w);
            if ((p->z >= near_z) != (q->z >= near_z)) {
                double t = (near_z - p->z) / (q->z - p->z), w = near_z * (double)r->map->extent;
                rsm__widen(box, (p->x + t * (q->x - p->x)) / w, (p->y + t * (q->y - p->y)) / w);
            }
        }
    for (k = 0; k < 4; k++) {                    /* a hair wider: the edge functions decide */
        double t = (box[k] + 1.0) * 0.5 * size - 0.5;
        t = k < 2 ? ceil(t - 1e-6 * size) : floor(t + 1e-6 * size);
        box[k] = t < 0.0 && k < 2 ? 0.0 : t > size - 1.0 && k >= 2 ? size - 1.0 : t;
    }
    if (!(box[0] <= box[2] && box[1] <= box[3])) return out;
    out.x0 = (uint16_t)box[0];
    out.y0 = (uint16_t)box[1];
    out.x1 = (uint16_t)box[2];
    out.y1 = (uint16_t)box[3];
    return out;
}

static inline int rsm__corners_usable(const rsm__v3 p[3])
{
    rsm__v3 n = rsm__v3_cross(rsm__v3_sub(p[1], p[0]), rsm__v3_sub(p[2], p[0]));
    return rsm__usable(p[0]) && rsm__usable(p[1]) && rsm__usable(p[2]) && (n.x != 0.0f || n.y != 0.0f || n.z != 0.0f);
}

static inline void rsm__bound_chunk(void *context, size_t chunk)
{
    rsm__raster *r = (rsm__raster *)context;
    size_t i, first = chunk * RSM__CHUNK, triangle,
              end = first + RSM__CHUNK < r->triangles ? first + RSM__CHUNK : r->triangles;
    const rsm_mesh *m = rsm__mesh_of(r, first, &triangle);
    for (i = first; i < end; i++, triangle++) {
        rsm__v3 p[3];
        rsm__corner c[3];
        int k;
        while (triangle >= rsm__mesh_triangles(m)) {
            m++;
            triangle = 0;
        }
        for (k = 0; k < 3; k++) p[k] = rsm__mesh_corner(m, triangle, k);
        r->boxes[i].x0 = 1;
        r->boxes[i].x1 = 0;
        if (!rsm__corners_usable(p)) continue;
        for (k = 0; k < 3; k++) c[k] = rsm__project_corner(r, p[k]);
        r->boxes[i] = rsm__bound(r, c);
    }
}

typedef struct rsm__edges { double a[3], b[3], c[3], determinant; int owned[3]; } rsm__edges;

/* Edge k at (x, y): a x + b y + c, positive inside. 0: seen edge-on. */
static inline int rsm__edges_make(rsm__edges *e, const rsm__corner p[3])
{
    int k;
    for (k = 0; k < 3; k++) {
        const rsm__corner *u = &p[(k + 1) % 3], *v = &p[(k + 2) % 3];
        e->a[k] = u->y * v->w - u->w * v->y;
        e->b[k] = u->w * v->x - u->x * v->w;
        e->c[k] = u->x * v->y - u->y * v->x;
    }
    e->determinant = p[0].x * e->a[0] + p[0].y * e->b[0] + p[0].w * e->c[0];
    for (k = 0; k < 3; k++) {
        if (e->determinant < 0.0) {
            e->a[k] = -e->a[k];
            e->b[k] = -e->b[k];
            e->c[k] = -e->c[k];
        }
        e->owned[k] = e->a[k] > 0.0 || (e->a[k] == 0.0 && e->b[k] > 0.0);
    }
    return e->determinant != 0.0;
}

static inline int rsm__inside(const rsm__edges *e, double x, double y, double w[3])
{
    double sum;
    int k;
    for (k = 0; k < 3; k++) {
        w[k] = e->a[k] * x + e->b[k] * y + e->c[k];
        if (!(w[k] > 0.0 || (w[k] == 0.0 && e->owned[k]))) return 0;
    }
    sum = w[0] + w[1] + w[2];
    if (!(sum > 0.0)) return 0;
    for (k = 0; k < 3; k++) w[k] /= sum;
    return 1;
}

static inline int rsm__is_hole(const rsm_mesh *m, size_t triangle, const double w[3])
{
    float weights[3] = { (float)w[0], (float)w[1], (float)w[2] }, albedo[3] = { 0, 0, 0 };
    return m->has_holes && m->surface_fn && !m->surface_fn(m->user, m, (uint32_t)triangle, weights, albedo);
}

/* One triangle into the rows y0..y1 of the face. The depth of what wins stands in the texels. */
static inline void rsm__draw(const rsm__raster *r, const rsm_mesh *m, size_t triangle, size_t number, uint32_t y0,
                             uint32_t y1)
{
    rsm__box box = r->boxes[number];
    double size = r->map->size, low = (double)r->map->desc.light.near_depth,
           high = (double)r->map->desc.light.far_depth;
    rsm__corner c[3];
    rsm__edges e;
    uint32_t x, y;
    int k;
    for (k = 0; k < 3; k++) c[k] = rsm__project_corner(r, rsm__mesh_corner(m, triangle, k));
    if (!rsm__edges_make(&e, c)) return;
    for (y = box.y0 > y0 ? box.y0 : y0; y <= box.y1 && y <= y1; y++)
        for (x = box.x0; x <= box.x1; x++) {
            size_t at = ((size_t)r->face * r->map->size + y) * r->map->size + x;
            double w[3], z;
            if (!rsm__inside(&e, (x + 0.5) * 2.0 / size - 1.0, (y + 0.5) * 2.0 / size - 1.0, w)) continue;
            z = w[0] * c[0].z + w[1] * c[1].z + w[2] * c[2].z;
            if (!(z >= low && z <= high && (float)z < r->map->texels[at].depth) || rsm__is_hole(m, triangle, w))
                continue;
            r->map->texels[at].depth = (float)z;
            r->winners[(size_t)y * r->map->size + x] = (uint32_t)number + 1u;
        }
}

/* Mean of surface_fn over taps x taps points of the texel, in the triangle's plane. */
static inline void rsm__albedo(const rsm_mesh *m, size_t triangle, const rsm__edges *e, double x, double y, double h,
                               float out[3])
{
    uint32_t taps = m->taps ? m->taps : 1, i, j, found = 0;
    float sum[3] = { 0, 0, 0 };
    int k;
    for (k = 0; k < 3; k++) out[k] = m->albedo[k];
    if (!m->surface_fn) return;
    for (j = 0; j < taps; j++)
        for (i = 0; i < taps; i++) {
            double s = x + h * ((2.0 * i + 1.0) / taps - 1.0), t = y + h * ((2.0 * j + 1.0) / taps - 1.0), total = 0.0,
                   w[3];
            float weights[3], albedo[3] = { 0, 0, 0 };
            for (k = 0; k < 3; k++) {
                w[k] = e->a[k] * s + e->b[k] * t + e->c[k];
                w[k] = w[k] > 0.0 ? w[k] : 0.0;                     /* beyond an edge: the edge */
                total += w[k];
            }
            for (k = 0; k < 3; k++) weights[k] = total > 0.0 ? (float)(w[k] / total) : 1.0f / 3.0f;
            if (!m->surface_fn(m->user, m, (uint32_t)triangle, weights, albedo)) continue;
            for (k = 0; k < 3; k++) sum[k] += albedo[k];
            found++;
        }
    for (k = 0; k < 3; k++) out[k] = found ? sum[k] / (float)found : 0.0f;
}

static inline void rsm__resolve_texel(const rsm__raster *r, uint32_t x, uint32_t y)
{
    uint32_t winner = r->winners[(size_t)y * r->map->size + x];
    double size = r->map->size, s = (x + 0.5) * 2.0 / size - 1.0, t = (y + 0.5) * 2.0 / size - 1.0, w[3];
    size_t triangle;
    const rsm_mesh *m;
    rsm__v3 p[3], normal, position;
    rsm__corner c[3];
    rsm__edges e;
    float albedo[3];
    int k;
    if (!winner) return;
    m = rsm__mesh_of(r, winner - 1u, &triangle);
    for (k = 0; k < 3; k++) {
        p[k] = rsm__mesh_corner(m, triangle, k);
        c[k] = rsm__project_corner(r, p[k]);
    }
    rsm__edges_make(&e, c);
    if (!rsm__inside(&e, s, t, w)) return;
    normal = rsm__v3_normalize(rsm__v3_cross(rsm__v3_sub(p[1], p[0]), rsm__v3_sub(p[2], p[0])));
    position = rsm__v3_make((float)(w[0] * (double)p[0].x + w[1] * (double)p[1].x + w[2] * (double)p[2].x),
                            (float)(w[0] * (double)p[0].y + w[1] * (double)p[1].y + w[2] * (double)p[2].y),
                            (float)(w[0] * (double)p[0].z + w[1] * (double)p[1].z + w[2] * (double)p[2].z));
    if (rsm__v3_dot(normal, rsm__to_light(r->map, position)) < 0.0f) normal = rsm__v3_scale(normal, -1);
    rsm__albedo(m, triangle, &e, s, t, 1.0 / size, albedo);
    rsm__texel_set(r->map, r->face, x, y, position, normal, albedo, m->material);
}

static inline void rsm__draw_band(void *context, size_t band)
{
    const rsm__raster *r = (const rsm__raster *)context;
    uint32_t y0 = (uint32_t)band * RSM__BAND, y1 = y0 + RSM__BAND - 1u, x, y;
    size_t number = 0, triangle, mesh;
    if (y1 >= r->map->size) y1 = r->map->size - 1u;
    for (mesh = 0; mesh < r->mesh_count; mesh++)
        for (triangle = 0; triangle < rsm__mesh_triangles(r->meshes + mesh); triangle++, number++) {
            rsm__box b = r->boxes[number];
            if (b.x0 <= b.x1 && b.y0 <= y1 && b.y1 >= y0) rsm__draw(r, r->meshes + mesh, triangle, number, y0, y1);
        }
    for (y = y0; y <= y1; y++)
        for (x = 0; x < r->map->size; x++) rsm__resolve_texel(r, x, y);
}

static inline rsm_result rsm__meshes_check(rsm__raster *r, uint64_t *skipped)
{
    size_t i, k, triangle;
    r->triangles = 0;
    for (i = 0; i < r->mesh_count; i++) {
        const rsm_mesh *m = r->meshes + i;
        size_t count = rsm__mesh_triangles(m);
        if ((!m->positions && m->vertex_count) || !rsm__stride_valid(m->vertex_stride, 12)) return RSM_ERR_ARGUMENT;
        if ((m->indices ? m->index_count : m->vertex_count) % 3 != 0) return RSM_ERR_INPUT;
        if (m->taps > 16) return RSM_ERR_ARGUMENT;
        for (k = 0; k < 3; k++)
            if (!(m->albedo[k] >= 0.0f && m->albedo[k] <= 1e6f)) return RSM_ERR_INPUT;
        if (m->transform)
            for (k = 0; k < 16; k++)
                if (!rsm__finite(m->transform[k])) return RSM_ERR_INPUT;
        if (m->indices)
            for (k = 0; k < m->index_count; k++)
                if (m->indices[k] >= m->vertex_count) return RSM_ERR_INPUT;
        if (count > 0xfffffffeu - r->triangles) return RSM_ERR_LIMIT;
        r->triangles += count;
        for (triangle = 0; triangle < count; triangle++) {
            rsm__v3 p[3];
            for (k = 0; k < 3; k++) p[k] = rsm__mesh_corner(m, triangle, (int)k);
            *skipped += !rsm__corners_usable(p);
        }
    }
    return RSM_OK;
}

static inline rsm_result rsm__raster_faces(rsm__raster *r)
{
    const rsm_system *s = &r->map->desc.system;
    size_t texels = (size_t)r->map->size * r->map->size;
    float share = 1.0f / (float)r->map->faces;
    for (r->face = 0; r->face < r->map->faces; r->face++) {
        rsm__face_frame(r->map, r->face, &r->right, &r->up, &r->axis);
        memset(r->winners, 0, texels * sizeof *r->winners);
        rsm__run(s, (r->triangles + RSM__CHUNK - 1) / RSM__CHUNK, rsm__bound_chunk, r);
        if (!rsm__run_steps(s, (r->map->size + RSM__BAND - 1) / RSM__BAND, rsm__draw_band, r, share * (float)r->face,
                            share * (float)(r->face + 1)))
            return RSM_ERR_CANCELLED;
    }
    return RSM_OK;
}

/* ---- >>patterns ---- */

static inline void rsm__disc_point(float *out, float radius, float turn, float weight)
{
    float s, c;
    rsm__sincos(turn * (2.0f * RSM__PI), &s, &c);
    out[0] = radius * c;
    out[1] = radius * s;
    out[2] = weight;
}

/* Darts on a torus twice the disc's radius wide, the least distance lowered whenever too many miss, so that every
   pattern is finished. No place of the torus differs from another, so that the disc is covered evenly up to its rim,
   where darts thrown at the disc alone crowd (4 % too dark in T25 with 400). */
static inline void rsm__poisson(uint32_t count, uint32_t seed, float *out)
{
    /* Pairs from the front are points of the disc, pairs from the back (27 % of the darts) those in the square's
     * corners. */
    float least = 1.5f / sqrtf((float)count);
    uint32_t found = 0, outside = 0, tries = 0, dart, i;
    for (dart = 0; found < count; dart++) {
        float x = 2.0f * rsm__random(seed, 11, dart) - 1.0f, y = 2.0f * rsm__random(seed, 12, dart) - 1.0f;
        int hit = 0;
        for (i = 0; i < found + outside && !hit; i++) {
            const float *p = i < found ? out + 2 * i : out + 3 * count - 2 * (i - found + 1);
            float dx = fabsf(p[0] - x), dy = fabsf(p[1] - y);
            dx = dx < 1.0f ? dx : 2.0f - dx;
            dy = dy < 1.0f ? dy : 2.0f - dy;
            hit = dx * dx + dy * dy < least * least;
        }
        if (hit) {
            if (++tries < 100) continue;
            least *= 0.9f;
        } else if (x * x + y * y < 1.0f) {
            out[2 * found] = x;
            out[2 * found++ + 1] = y;
        } else if (outside < count / 2) {
            outside++;
            out[3 * count - 2 * outside] = x;
            out[3 * count - 2 * outside + 1] = y;
        }
        tries = 0;
    }
    for (i = count; i-- > 0;) {
        float x = out[2 * i], y = out[2 * i + 1];
        out[3 * i] = x;
        out[3 * i + 1] = y;
        out[3 * i + 2] = RSM__PI / (float)count;
    }
}

/* Density C / r^2 outside the inner disc and C / r_min^2 in it, each its share of the samples: two strata. Each is a
   lattice, radii at even steps and angles by the golden ratio, which is even for any number of samples. */
static inline void rsm__log_radial(uint32_t count, float r_min, uint32_t seed, float *out)
{
    float length = -rsm__log(r_min), u, v, r;
    uint32_t inner = (uint32_t)((float)count / (1.0f + 2.0f * length) + 0.5f), i;
    if (inner < 1) inner = 1;
    if (inner >= count) inner = count - 1;
    for (i = 0; i < count; i++) {
        uint32_t k = i < inner ? i : i - inner, n = i < inner ? inner : count - inner;
        u = ((float)k + rsm__random(seed, 8, i < inner)) / (float)n;
        v = rsm__fraction(rsm__to_unit(k * 2654435769u) + rsm__random(seed, 9, i < inner));
        if (i < inner) rsm__disc_point(out + 3 * i, r_min * sqrtf(u), v, RSM__PI * r_min * r_min / (float)inner);
        else {
            r = rsm__exp(-length * (1.0f - u));
            rsm__disc_point(out + 3 * i, r, v, 2.0f * RSM__PI * r * r * length / (float)(count - inner));
        }
    }
}

static inline void rsm__pattern_make(rsm_pattern pattern, uint32_t count, float r_min, int paper, uint32_t seed,
                                     float *out)
{
    float u, v;
    double sum = 0.0;
    uint32_t i;
    if (pattern == RSM_PATTERN_POISSON) rsm__poisson(count, seed, out);
    else if (pattern == RSM_PATTERN_LOG_RADIAL && count > 1) rsm__log_radial(count, r_min, seed, out);
    else
        for (i = 0; i < count; i++) {
            rsm__sobol2(i, seed, &u, &v);
            if (pattern == RSM_PATTERN_EQUATION3) rsm__disc_point(out + 3 * i, u, v, 2.0f * RSM__PI * u / (float)count);
            else rsm__disc_point(out + 3 * i, sqrtf(u), v, RSM__PI / (float)count);
        }
    if (!paper || pattern != RSM_PATTERN_EQUATION3) return;
    for (i = 0; i < count; i++) sum += (double)(out[3 * i] * out[3 * i] + out[3 * i + 1] * out[3 * i + 1]);
    for (i = 0; i < count && sum > 0.0; i++)
        out[3 * i + 2] = (float)(3.14159265358979 / sum) * (out[3 * i] * out[3 * i] + out[3 * i + 1] * out[3 * i + 1]);
}

RSM_DEF rsm_result rsm_pattern_build(rsm_pattern pattern, uint32_t samples, float r_min, int paper_weights,
                                     uint32_t seed, float *points)
{
    if (!points || samples == 0 || samples > RSM__MAX_SAMPLES || !(r_min >= 0.0f && r_min < 1.0f))
        return RSM_ERR_ARGUMENT;
    if ((int)pattern <= RSM_PATTERN_FLUX || pattern >= RSM_PATTERN_MIXED) return RSM_ERR_ARGUMENT;
    if (pattern == RSM_PATTERN_POISSON && samples > RSM__MAX_POISSON) return RSM_ERR_ARGUMENT;
    rsm__pattern_make(pattern, samples, r_min > 0.0f ? r_min : 1.0f / 32.0f, paper_weights, seed, points);
    return RSM_OK;
}

/* Energy of a set pixel about it on the torus: a Gaussian of sigma 1.9, Ulichney's 1.5 to 2. */
static inline void rsm__splat_energy(float *energy, uint32_t side, uint32_t at, float sign)
{
    int32_t reach = side > 20 ? 10 : ((int32_t)side - 1) / 2, i, j;
    for (j = -reach; j <= reach; j++)
        for (i = -reach; i <= reach; i++) {
            uint32_t x = (at % side + side + (uint32_t)i) % side, y = (at / side + side + (uint32_t)j) % side;
            energy[y * side + x] += sign * rsm__exp((float)(i * i + j * j) * -0.1385f);
        }
}

/* The tightest cluster among set pixels, or the largest void among unset ones: marks hold 0 or rank + 1. */
static inline uint32_t rsm__extreme(const float *energy, const float *marks, uint32_t count, int set)
{
    uint32_t i, best = 0;
    float value = 0.0f;
    int found = 0;
    for (i = 0; i < count; i++)
        if ((marks[i] > 0.0f) == set && (!found || (set ? energy[i] > value : energy[i] < value))) {
            best = i;
            value = energy[i];
            found = 1;
        }
    return best;
}

static inline void rsm__void_and_cluster(uint32_t side, uint32_t seed, float *energy, float *marks)
{
    uint32_t count = side * side, first = count / 10 + 1, i, k;
    for (i = 0; i < count; i++) energy[i] = marks[i] = 0.0f;
    for (i = 0, k = 0; i < first; k++) {
        uint32_t at = rsm__hash_combine(seed, k) % count;
        if (marks[at] > 0.0f) continue;
        marks[at] = 1.0f;
        rsm__splat_energy(energy, side, at, 1.0f);
        i++;
    }
    for (k = 0; k < count; k++) {                /* spread the first ones evenly: tightest into largest void */
        uint32_t from = rsm__extreme(energy, marks, count, 1), to;
        marks[from] = 0.0f;
        rsm__splat_energy(energy, side, from, -1.0f);
        to = rsm__extreme(energy, marks, count, 0);
        marks[to] = 1.0f;
        rsm__splat_energy(energy, side, to, 1.0f);
        if (to == from) break;
    }
    for (i = 0; i < count; i++)
        if (marks[i] > 0.0f) marks[i] = 0.5f;    /* set, rank not known yet */
    for (k = first; k-- > 0;) {                  /* ranks below: taking away the tightest; 0.5 alone still counts */
        uint32_t at, best = count;
        for (at = 0; at < count; at++)
            if (marks[at] == 0.5f && (best == count || energy[at] > energy[best])) best = at;
        marks[best] = (float)k + 1.0f;
        rsm__splat_energy(energy, side, best, -1.0f);
    }
    for (i = 0; i < count; i++) energy[i] = 0.0f;
    for (i = 0; i < count; i++)
        if (marks[i] > 0.0f) rsm__splat_energy(energy, side, i, 1.0f);
    for (k = first; k < count; k++) {
        uint32_t at = rsm__extreme(energy, marks, count, 0);
        marks[at] = (float)k + 1.0f;
        rsm__splat_energy(energy, side, at, 1.0f);
    }
    for (i = 0; i < count; i++) marks[i] = (marks[i] - 0.5f) / (float)count;
}

RSM_DEF rsm_result rsm_blue_noise(uint32_t side, uint32_t seed, const rsm_system *system, float *values)
{
    rsm_system none;
    rsm__allocator a;
    float *energy;
    memset(&none, 0, sizeof none);
    if (!system) system = &none;
    if (!values || side < 4 || side > 64 || !rsm__system_valid(system)) return RSM_ERR_ARGUMENT;
    a = rsm__allocator_of(system);
    energy = (float *)rsm__alloc_array(&a, (size_t)side * side, sizeof *energy);
    if (!energy) return RSM_ERR_ALLOC;
    rsm__void_and_cluster(side, seed, energy, values);
    rsm__free(&a, energy);
    return RSM_OK;
}

/* ---- >>kernel: pixel lights on one receiver ---- */

/* What cosines times distances from a place must exceed. Each light's own, not that of the map's farthest: a sky dome
   far off would take all light between near surfaces away. */
static inline float rsm__rounding(float x, float y, float z)
{
    float most = fabsf(x) > fabsf(y) ? fabsf(x) : fabsf(y);
    return 4e-7f * (most > fabsf(z) ? most : fabsf(z));
}

/* Structure of arrays; unused lanes have no flux. */
typedef struct rsm__block {
    float px[RSM__BLOCK], py[RSM__BLOCK], pz[RSM__BLOCK], nx[RSM__BLOCK], ny[RSM__BLOCK], nz[RSM__BLOCK];
    float r[RSM__BLOCK], g[RSM__BLOCK], b[RSM__BLOCK], cap[RSM__BLOCK];
    float rounding[RSM__BLOCK];    /* of its position, see rsm__rounding */
    float lx[RSM__BLOCK], ly[RSM__BLOCK], lz[RSM__BLOCK], density[RSM__BLOCK]; /* MIXED: place in the map, see there; or
                                                                   face of a texel and squared distance that is near */
} rsm__block;

typedef struct rsm__gloss {
    float mirror[3], exponent, scale[3];
} rsm__gloss; /* scale: pi x intensity of the lobe */

typedef struct rsm__sum {
    float rgb[3];
    float full, lost;              /* only where they are asked for, as */
    float nearby;                  /* likewise: 1 / squared distance of the nearest light that is not edge-on */
} rsm__sum;

#define RSM__NO_CAP 3.0e38f

/* Equation (1) of light i of block k, with the 1/pi that it lacks applied by the caller: flux cos cos / d^2, cosines
   times d over d^4. Both must exceed the rounding of either position, so that a plane does not light itself (T40).
   X(c): the receiver's position, normal, rounding. g is free, f within the light's bound. */
#define RSM__FORM(k, i, X)                                                                                   \
    float dx = (k)->px[i] - X(0), dy = (k)->py[i] - X(1), dz = (k)->pz[i] - X(2);                            \
    float rounding = (k)->rounding[i] > X(6) ? (k)->rounding[i] : X(6);                                      \
    float d2 = dx * dx + dy * dy + dz * dz, cr = X(3) * dx + X(4) * dy + X(5) * dz - rounding, inverse, f, g; \
    float ce = -((k)->nx[i] * dx + (k)->ny[i] * dy + (k)->nz[i] * dz) - rounding;                            \
    cr = cr > 0.0f ? cr : 0.0f;                                                                              \
    ce = ce > 0.0f ? ce : 0.0f;                                                                              \
    inverse = 1.0f / (d2 > 1e-18f ? d2 : 1e-18f);                                                            \
    g = (cr * inverse) * (ce * inverse);                                                                     \
    f = g < (k)->cap[i] ? g : (k)->cap[i]

/* Written for lanes: compilers turn the inner loop into vectors, and the sums of lanes are added in one order, so that
   all builds give the same bits. */
#define RSM__ONE(c) x[c]
#define RSM__KERNEL_BODY(lossy, nearest)                                                                              \
    float red[RSM__LANES] = { 0 }, green[RSM__LANES] = { 0 }, blue[RSM__LANES] = { 0 };                      \
    float full[RSM__LANES] = { 0 }, lost[RSM__LANES] = { 0 }, nearby[RSM__LANES] = { 0 };                    \
    size_t i, l, end;                                                                                        \
    for (; count > 0; count -= end, k++)                                                                     \
        for (i = 0, end = count < RSM__BLOCK ? count : (size_t)RSM__BLOCK; i < end; i += RSM__LANES)         \
        for (l = 0; l < RSM__LANES; l++) {                                                                   \
            RSM__FORM(k, i + l, RSM__ONE);                                                                   \
            red[l] += k->r[i + l] * f;                                                                       \
            green[l] += k->g[i + l] * f;                                                                     \
            blue[l] += k->b[i + l] * f;                                                                      \
            if (lossy) {                                                                                     \
                float m = k->r[i + l] + k->g[i + l] + k->b[i + l];                                           \
                full[l] += m * g;                                                                            \
                lost[l] += m * (g - f);                                                                      \
            }                                                                                                \
            if (nearest) {                                                                                   \
                float reached = g * d2 > 1e-3f ? inverse : 0.0f;                                             \
                nearby[l] = reached > nearby[l] ? reached : nearby[l];                                       \
            }                                                                                                \
        }                                                                                                    \
    for (l = 0; l < RSM__LANES; l++) {                                                                       \
        sum->rgb[0] += red[l];                                                                               \
        sum->rgb[1] += green[l];                                                                             \
        sum->rgb[2] += blue[l];                                                                              \
        if (lossy) {                                                                                         \
            sum->full += full[l];                                                                            \
            sum->lost += lost[l];                                                                            \
        }                                                                                                    \
        if (nearest) sum->nearby = nearby[l] > sum->nearby ? nearby[l] : sum->nearby;                        \
    }

/* The other way round: a few lights on as many receivers as there are lanes. */
typedef struct rsm__crowd {
    float  x[7][RSM__WIDE];        /* positions, normals, roundings; no normal: no receiver */
    float  sums[5][RSM__WIDE];     /* red, green, blue; full and lost */
    size_t at[RSM__WIDE], count;
} rsm__crowd;

typedef void (*rsm__crowd_kernel)(const rsm__block *k, size_t count, rsm__crowd *p);

#define RSM__MANY(c) p->x[c][l]
#define RSM__CROWD_BODY(lossy, lanes)                                                                        \
    float red[RSM__WIDE] = { 0 }, green[RSM__WIDE] = { 0 }, blue[RSM__WIDE] = { 0 };                         \
    float full[RSM__WIDE] = { 0 }, lost[RSM__WIDE] = { 0 };                                                  \
    size_t i, l;                                                                                             \
    for (i = 0; i < count; i++) {                                                                            \
        const rsm__block *b = k + i / RSM__BLOCK;                                                            \
        size_t j = i % RSM__BLOCK;                                                                           \
        for (l = 0; l < (lanes); l++) {                                                                          \
            RSM__FORM(b, j, RSM__MANY);                                                                      \
            red[l] += b->r[j] * f;                                                                           \
            green[l] += b->g[j] * f;                                                                         \
            blue[l] += b->b[j] * f;                                                                          \
            if (lossy) {                                                                                     \
                float m = b->r[j] + b->g[j] + b->b[j];                                                       \
                full[l] += m * g;                                                                            \
                lost[l] += m * (g - f);                                                                      \
            }                                                                                                \
        }                                                                                                    \
    }                                                                                                        \
    for (l = 0; l < (lanes); l++) {                                                                          \
        p->sums[0][l] += red[l];                                                                             \
        p->sums[1][l] += green[l];                                                                           \
        p->sums[2][l] += blue[l];                                                                            \
        p->sums[3][l] += full[l];                                                                            \
        p->sums[4][l] += lost[l];                                                                            \
    }

#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__) && defined(__OPTIMIZE__)
#define RSM__HOT __attribute__((optimize("O3")))
#else
#define RSM__HOT
#endif

/* Into kernels of several targets. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define RSM__INLINE static inline __attribute__((always_inline))
#elif defined(_MSC_VER)
#define RSM__INLINE static __forceinline
#else
#define RSM__INLINE static inline
#endif

#if defined(__GNUC__) && !defined(__TINYC__)
#define RSM__PREFETCH(p) __builtin_prefetch(p)
#else
#define RSM__PREFETCH(p) (void)(p)
#endif

/* k: as many blocks as count lanes fill, a multiple of RSM__LANES. x: position, normal, rounding of the receiver. */
typedef void (*rsm__kernel)(const rsm__block *k, size_t count, const float x[7], rsm__sum *sum);

#define RSM__KERNELS(name, target)                                                                           \
    target RSM__HOT static void name(const rsm__block *k, size_t count, const float x[7], rsm__sum *sum)     \
    {                                                                                                        \
        RSM__KERNEL_BODY(0, 0)                                                                               \
    }                                                                                                        \
    target RSM__HOT static void name##_lossy(const rsm__block *k, size_t count, const float x[7], rsm__sum *sum) \
    {                                                                                                        \
        RSM__KERNEL_BODY(1, 0)                                                                               \
    }                                                                                                        \
    target RSM__HOT static void name##_near(const rsm__block *k, size_t count, const float x[7], rsm__sum *sum) \
    {                                                                                                        \
        RSM__KERNEL_BODY(0, 1)                                                                               \
    }                                                                                                        \
    target RSM__HOT static void name##_near_lossy(const rsm__block *k, size_t count, const float x[7], rsm__sum *sum) \
    {                                                                                                        \
        RSM__KERNEL_BODY(1, 1)                                                                               \
    }

#define RSM__CROWDS(name, target, lanes)                                                                     \
    target RSM__HOT static void name##_crowd(const rsm__block *k, size_t count, rsm__crowd *p)               \
    {                                                                                                        \
        RSM__CROWD_BODY(0, lanes)                                                                            \
    }                                                                                                        \
    target RSM__HOT static void name##_crowd_lossy(const rsm__block *k, size_t count, rsm__crowd *p)         \
    {                                                                                                        \
        RSM__CROWD_BODY(1, lanes)                                                                            \
    }

#define RSM__ANY_TARGET
RSM__KERNELS(rsm__kernel_plain, RSM__ANY_TARGET)
RSM__CROWDS(rsm__kernel_plain, RSM__ANY_TARGET, 8)
#if RSM__X86
RSM__KERNELS(rsm__kernel_avx2, RSM__TARGET_AVX2)
RSM__CROWDS(rsm__kernel_avx2, RSM__TARGET_AVX2, 8)
RSM__CROWDS(rsm__kernel_avx512, RSM__TARGET_AVX512, 16)
#endif

static inline rsm__kernel rsm__choose_kernel(int lossy, int nearby)
{
#if RSM__X86
    if (rsm__cpu_has_avx2() && nearby) return lossy ? rsm__kernel_avx2_near_lossy : rsm__kernel_avx2_near;
    if (rsm__cpu_has_avx2()) return lossy ? rsm__kernel_avx2_lossy : rsm__kernel_avx2;
#endif
    if (nearby) return lossy ? rsm__kernel_plain_near_lossy : rsm__kernel_plain_near;
    return lossy ? rsm__kernel_plain_lossy : rsm__kernel_plain;
}

static inline rsm__crowd_kernel rsm__choose_crowd(int lossy, size_t *lanes)
{
    *lanes = 8;
#if RSM__X86
    if (rsm__cpu_has_avx512()) {
        *lanes = 16;
        return lossy ? rsm__kernel_avx512_crowd_lossy : rsm__kernel_avx512_crowd;
    }
    if (rsm__cpu_has_avx2()) return lossy ? rsm__kernel_avx2_crowd_lossy : rsm__kernel_avx2_crowd;
#endif
    return lossy ? rsm__kernel_plain_crowd_lossy : rsm__kernel_plain_crowd;
}

/* The glossy part of a light towards a receiver: a Phong lobe about the mirrored direction of the light (section 7).
   mean: of cos cos / d^2 over a texel that is near, whose lobe is that of its centre; below 0: a point. */
static inline void rsm__add_gloss(const rsm__gloss *gloss, const rsm__block *k, size_t i, const float x[7], float mean,
                                  rsm__sum *sum)
{
    rsm__v3 d = rsm__v3_make(k->px[i] - x[0], k->py[i] - x[1], k->pz[i] - x[2]);
    float d2 = rsm__v3_dot(d, d), inverse = 1.0f / (d2 > 1e-18f ? d2 : 1e-18f), root = sqrtf(inverse), f;
    float rounding = k->rounding[i] > x[6] ? k->rounding[i] : x[6];
    float cr = (x[3] * d.x + x[4] * d.y + x[5] * d.z - rounding) * root;
    float ce = (-(k->nx[i] * d.x + k->ny[i] * d.y + k->nz[i] * d.z) - rounding) * root;
    float cm = -(gloss->mirror[0] * d.x + gloss->mirror[1] * d.y + gloss->mirror[2] * d.z) * root;
    int c;
    if (!(cm > 0.0f && (mean >= 0.0f || (cr > 0.0f && ce > 0.0f)))) return;
    f = mean >= 0.0f ? mean : cr * ce * inverse;
    f = (f < k->cap[i] ? f : k->cap[i]) * rsm__pow(cm < 1.0f ? cm : 1.0f, gloss->exponent);
    for (c = 0; c < 3; c++) sum->rgb[c] += gloss->scale[c] * f;
}

/* ---- >>gather ---- */

typedef struct rsm__reach {        /* where receivers are near some of a few lights: within sqrt(most2) of the box */
    float low[3], high[3], most2;
} rsm__reach;

typedef struct rsm__source {       /* one map, or the list */
    const rsm_map *map;            /* NULL for a list */
    rsm__block    *blocks;         /* pixel lights that all receivers share, set by set */
    rsm__gloss    *gloss;          /* of them, or NULL */
    size_t         set_blocks, set_lights, set_lanes;   /* of one set; lanes in use are a multiple of RSM__LANES */
    rsm__reach    *reaches;        /* NULL: lights are points everywhere; or of each block, then of each run */
    size_t         set_runs;
} rsm__source;

typedef struct rsm__tally { uint64_t evaluated, pairs, bad; double full, lost, outside, looked; } rsm__tally;

typedef struct rsm__gather {
    const rsm_map *const *maps;
    rsm_gather_desc   desc;
    const rsm_points *points;
    float            *out;
    rsm__source      *sources;
    size_t            source_count, count;       /* count: of receivers */
    float            *pattern;                   /* x, y, weight; set by set */
    uint32_t          sets, set_samples;
    uint32_t          shared, centred;           /* samples of each kind; both with MIXED */
    rsm__kernel       kernel;
    rsm__crowd_kernel crowd_kernel;
    size_t            crowd_lanes;
    rsm__tally       *tallies;                   /* one a batch or row */
    float             scale;                     /* of results: 1 / pi */
    float            *reach2;                    /* NULL, or of each point: squared distance of the nearest light */
} rsm__gather;

/* ---- >>near: texels as the parallelograms that they are ---- */

/* Half the sides of the surface under a texel at p: the cross section of its beam, along the beam onto the plane of n.
   The area is t->area, since grazing ones are bounded alike, along the light. */
static inline void rsm__texel_sides(const rsm_map *map, uint32_t face, rsm__v3 p, rsm__v3 n, rsm__v3 side[2])
{
    rsm__v3 a, d, along;
    float scale = map->extent / (float)map->size, facing, least, bounded, length2;
    int k;
    rsm__face_frame(map, face, &side[0], &side[1], &a);
    d = a;
    if (!rsm__is_sun(map)) {                     /* from the light, as far as the plane at distance 1 */
        d = rsm__v3_sub(p, rsm__v3_load(map->desc.light.position));
        scale *= rsm__v3_dot(d, a);
        d = rsm__v3_scale(d, 1.0f / rsm__v3_dot(d, a));
    }
    facing = rsm__v3_dot(d, n);
    least = 0.05f * rsm__v3_length(d);
    bounded = rsm__copysign(fabsf(facing) > least ? fabsf(facing) : least, facing);
    along = rsm__v3_madd(d, n, -facing);
    length2 = rsm__v3_dot(along, along);
    for (k = 0; k < 2; k++) {
        float off = rsm__v3_dot(side[k], n), stretched = off / bounded;
        if (fabsf(facing) < least)
            stretched += rsm__v3_dot(side[k], along) / length2 * (1.0f - fabsf(facing) / least);
        side[k] = rsm__v3_scale(rsm__v3_madd(rsm__v3_madd(side[k], n, -off), along, -stretched), scale);
    }
}

/* An edge's share of Lambert's sum: angle(a, b) n . (b x a) / |b x a|. */
static inline float rsm__edge(rsm__v3 n, rsm__v3 a, rsm__v3 b)
{
    rsm__v3 c = rsm__v3_cross(rsm__v3_sub(b, a), a);
    float length = rsm__v3_length(c);
    return length > 0.0f ? rsm__atan2(length, rsm__v3_dot(a, b)) * (rsm__v3_dot(n, c) / length) : 0.0f;
}

/* Integral of cos cos / d^2 over the parallelogram c +- u +- v, seen from the origin and clipped at the horizon of n:
   pi times the form factor, half of Lambert's sum over the edges (Baum, Rushmeier and Winget 1989). Convex, so the
   horizon cuts it once at most: where it leaves and where it comes back are joined. */
static inline float rsm__form_of(rsm__v3 n, rsm__v3 c, rsm__v3 u, rsm__v3 v)
{
    rsm__v3 corner[4], leave = c, come = c;
    float height[4], sum = 0.0f;
    int k;
    for (k = 0; k < 4; k++) {
        corner[k] = rsm__v3_madd(rsm__v3_madd(c, u, k == 1 || k == 2 ? 1.0f : -1.0f), v, k > 1 ? 1.0f : -1.0f);
        height[k] = rsm__v3_dot(n, corner[k]);
    }
    for (k = 0; k < 4; k++) {
        rsm__v3 a = corner[k], b = corner[(k + 1) & 3];
        float ha = height[k], hb = height[(k + 1) & 3];
        if (!(ha > 0.0f) && !(hb > 0.0f)) continue;
        if (!(ha > 0.0f && hb > 0.0f)) {
            rsm__v3 at = rsm__v3_madd(a, rsm__v3_sub(b, a), ha / (ha - hb));
            if (ha > 0.0f) b = leave = at;
            else a = come = at;
        }
        sum += rsm__edge(n, a, b);
    }
    return 0.5f * fabsf(sum + rsm__edge(n, leave, come));
}

/* The mean of cos cos / d^2 over the texel in lane i; as of points, a plane does not light itself. A receiver that
   faces the texel (fully from 120 degrees between their normals) nearer than half its side to its plane gets no more
   than from a point, by degrees: so lies the back of a bent sheet that is lit from its other side, through which the
   parallelogram reaches, and depths cannot tell the two apart. */
static inline float rsm__near_form(const rsm_map *map, const rsm__block *k, size_t i, const float x[7])
{
    rsm__v3 p = rsm__v3_make(k->px[i], k->py[i], k->pz[i]), n = rsm__v3_make(k->nx[i], k->ny[i], k->nz[i]), side[2];
    rsm__v3 d = rsm__v3_sub(p, rsm__v3_load(x));
    float area, form, point, height = -rsm__v3_dot(n, d), d2 = rsm__v3_dot(d, d);
    float facing = -2.0f * rsm__v3_dot(n, rsm__v3_load(x + 3)), above = rsm__v3_dot(rsm__v3_load(x + 3), d);
    if (!(height > (k->rounding[i] > x[6] ? k->rounding[i] : x[6]))) return 0.0f;
    rsm__texel_sides(map, (uint32_t)k->lx[i], p, n, side);
    area = 4.0f * rsm__v3_length(rsm__v3_cross(side[0], side[1]));
    form = area > 0.0f ? rsm__form_of(rsm__v3_load(x + 3), d, side[0], side[1]) / area : 0.0f;
    point = above > 0.0f ? (above / d2) * (height / d2) : 0.0f;
    if (form > point && facing > 0.0f && 4.0f * height * height < area)
        form += (facing < 1.0f ? facing : 1.0f) * (1.0f - 2.0f * height / sqrtf(area)) * (point - form);
    return form > 0.0f ? form : 0.0f;            /* not a number: positions beyond what squares of floats hold */
}

static inline int rsm__is_near(const rsm__block *k, size_t i, const float x[7])
{
    float dx = k->px[i] - x[0], dy = k->py[i] - x[1], dz = k->pz[i] - x[2];
    return dx * dx + dy * dy + dz * dz < k->density[i];
}

/* The kernel where lights may be near: they are taken out of the block, which stays so, and added one by one. */
static inline void rsm__kernel_near(const rsm__gather *g, const rsm_map *map, rsm__block *k, size_t count,
                                    const float x[7], rsm__sum *sum)
{
    float flux[RSM__BLOCK][3];
    size_t found[RSM__BLOCK], nearby = 0, i, j;
    for (i = 0; i < count; i++) {
        if (!rsm__is_near(k, i, x)) continue;
        flux[nearby][0] = k->r[i];
        flux[nearby][1] = k->g[i];
        flux[nearby][2] = k->b[i];
        k->r[i] = k->g[i] = k->b[i] = 0.0f;
        found[nearby++] = i;
    }
    g->kernel(k, count, x, sum);
    for (j = 0; j < nearby; j++) {
        float form = rsm__near_form(map, k, found[j], x), f = form < k->cap[found[j]] ? form : k->cap[found[j]];
        int c;
        for (c = 0; c < 3; c++) {
            sum->rgb[c] += flux[j][c] * f;
            sum->full += flux[j][c] * form;
            sum->lost += flux[j][c] * (form - f);
        }
    }
}

static inline int rsm__reaches(const rsm__reach *r, const float x[7])
{
    float d2 = 0.0f;
    int c;
    for (c = 0; c < 3; c++) {
        float below = r->low[c] - x[c], above = x[c] - r->high[c], d = below > above ? below : above;
        d2 += d > 0.0f ? d * d : 0.0f;
    }
    return d2 < r->most2;
}

static inline void rsm__reach_add(rsm__reach *r, float px, float py, float pz, float most2)
{
    const float p[3] = { px, py, pz };
    int c;
    for (c = 0; c < 3; c++) {
        r->low[c] = p[c] < r->low[c] ? p[c] : r->low[c];
        r->high[c] = p[c] > r->high[c] ? p[c] : r->high[c];
    }
    r->most2 = most2 > r->most2 ? most2 : r->most2;
}

/* Of lights in place: the boxes of their blocks, then of their runs. Set by set, both. */
static inline rsm_result rsm__find_reaches(const rsm__gather *g, rsm__source *s, const rsm__allocator *a)
{
    static const rsm__reach nothing = { { 3e38f, 3e38f, 3e38f }, { -3e38f, -3e38f, -3e38f }, 0.0f };
    size_t blocks = s->set_blocks * g->sets, i, l;
    s->set_runs = (s->set_blocks + RSM__RUN / RSM__BLOCK - 1) / (RSM__RUN / RSM__BLOCK);
    s->reaches = (rsm__reach *)rsm__alloc_array(a, blocks + s->set_runs * g->sets, sizeof *s->reaches);
    if (!s->reaches) return RSM_ERR_ALLOC;
    for (i = 0; i < blocks + s->set_runs * g->sets; i++) s->reaches[i] = nothing;
    for (i = 0; i < blocks; i++) {
        const rsm__block *k = s->blocks + i;
        size_t run = i / s->set_blocks * s->set_runs + i % s->set_blocks / (RSM__RUN / RSM__BLOCK);
        for (l = 0; l < RSM__BLOCK; l++) {
            if (!(k->density[l] > 0.0f)) continue;
            rsm__reach_add(&s->reaches[i], k->px[l], k->py[l], k->pz[l], k->density[l]);
            rsm__reach_add(&s->reaches[blocks + run], k->px[l], k->py[l], k->pz[l], k->density[l]);
        }
    }
    return RSM_OK;
}

/* One run of a set's lights, lanes first .. of it, some of which may be near. */
static inline void rsm__gather_near(const rsm__gather *g, const rsm__source *s, uint32_t set, size_t first,
                                    size_t lanes, const float x[7], rsm__sum *sum)
{
    size_t i, at = set * s->set_blocks + first / RSM__BLOCK;
    for (i = 0; i < lanes; i += RSM__BLOCK, at++) {
        size_t count = lanes - i < RSM__BLOCK ? lanes - i : (size_t)RSM__BLOCK;
        if (rsm__reaches(&s->reaches[at], x)) {
            rsm__block some = s->blocks[at];
            rsm__kernel_near(g, s->map, &some, count, x, sum);
        } else g->kernel(s->blocks + at, count, x, sum);
    }
}

/* Puts a light into a lane. weight: how many such texels it stands for; sets: how many sets share the lights. The bound
   is that of the light among all sets, so that interleaving changes nothing on average. */
static inline void rsm__lane_set(const rsm_gather_desc *d, rsm__block *k, size_t i, const rsm_texel *t, float weight,
                                 float sets)
{
    float cap = d->clamp > 0.0f ? d->clamp : RSM__NO_CAP;
    if (d->near_limit > 0.0f && t->area * weight > 0.0f) {
        float own = d->near_limit * RSM__PI / (t->area * weight);
        cap = own < cap ? own : cap;
    }
    k->px[i] = t->position[0] - d->offset * t->normal[0];
    k->py[i] = t->position[1] - d->offset * t->normal[1];
    k->pz[i] = t->position[2] - d->offset * t->normal[2];
    k->rounding[i] = rsm__rounding(k->px[i], k->py[i], k->pz[i]);
    k->nx[i] = t->normal[0];
    k->ny[i] = t->normal[1];
    k->nz[i] = t->normal[2];
    k->r[i] = t->flux[0] * weight * sets;
    k->g[i] = t->flux[1] * weight * sets;
    k->b[i] = t->flux[2] * weight * sets;
    k->cap[i] = cap;
}

/* Of a texel in a lane that may be near. */
static inline void rsm__lane_near(const rsm_gather_desc *d, const rsm_map *map, rsm__block *k, size_t i, size_t at)
{
    float area = map->texels[at].area;
    k->density[i] = d->near_field * d->near_field * (area > 0.0f ? area : 0.0f);
    k->lx[i] = map->faces == 1 ? 0.0f : (float)(at / ((size_t)map->size * map->size));
}

static inline void rsm__lane_clear(rsm__block *k, size_t i)
{
    k->px[i] = k->py[i] = k->pz[i] = k->nx[i] = k->ny[i] = k->nz[i] = k->r[i] = k->g[i] = k->b[i] = 0.0f;
    k->rounding[i] = 0.0f;
    k->cap[i] = RSM__NO_CAP;
    k->lx[i] = k->ly[i] = k->lz[i] = k->density[i] = 0.0f;
}

/* at: of the texel in the map. */
static inline void rsm__gloss_set(const rsm_gather_desc *d, const rsm_map *map, rsm__gloss *g, size_t at, float weight)
{
    const rsm_texel *t = map->texels + at;
    size_t face = (size_t)map->size * map->size;
    rsm__v3 n = rsm__v3_load(t->normal), l = rsm__to_light(map, rsm__v3_load(t->position));
    float incident;
    int c;
    memset(g, 0, sizeof *g);
    if (t->material == 0 || t->material > d->material_count || !(t->depth < RSM_FAR)) return;
    rsm__v3_store(g->mirror, rsm__v3_sub(rsm__v3_scale(n, 2.0f * rsm__v3_dot(n, l)), l));
    g->exponent = d->materials[t->material - 1].exponent;
    incident = rsm__incident(map, (uint32_t)(at / face), (uint32_t)(at % map->size), (uint32_t)(at % face / map->size));
    for (c = 0; c < 3; c++)
        g->scale[c] = incident * map->desc.light.value[c] * weight * d->materials[t->material - 1].specular[c] *
                      0.5f * (g->exponent + 2.0f);
}

/* Texel number and weight of sample i of n, in proportion to flux. */
static inline int rsm__pick_texel(const rsm_map *map, uint32_t i, uint32_t n, uint32_t seed, size_t *at, float *weight)
{
    double total = map->rows[map->size * (size_t)map->faces], x, flux;
    uint32_t low = 0, high = map->size * map->faces, row;
    const double *sums;
    float u, v;
    if (!(total > 0.0)) return 0;
    /* A lattice: rows at even steps, places in them by the golden ratio, both shifted by the seed. */
    u = rsm__fraction(rsm__to_unit(i * 2654435769u) + rsm__random(seed, 5, 0));
    v = ((float)i + rsm__random(seed, 6, 0)) / (float)n;
    x = (double)(v < 0.99999994f ? v : 0.99999994f) * total;
    while (high - low > 1u) {
        uint32_t middle = low + (high - low) / 2u;
        if (map->rows[middle] <= x) low = middle;
        else high = middle;
    }
    row = low;
    sums = map->sums + (size_t)row * map->size;
    x = (double)(u < 0.99999994f ? u : 0.99999994f) * sums[map->size - 1];
    low = 0;
    high = map->size - 1;                        /* first texel whose sum exceeds x */
    while (low < high) {
        uint32_t middle = low + (high - low) / 2u;
        if (sums[middle] > x) high = middle;
        else low = middle + 1u;
    }
    flux = sums[low] - (low ? sums[low - 1] : 0.0);
    if (!(flux > 0.0)) return 0;
    *at = (size_t)row * map->size + low;
    *weight = (float)(total / ((double)n * flux));
    return 1;
}

/* MIXED: two ways to sample a texel, by flux with n1 P expected samples of it (P its share of the flux), and about the
   receiver with B / q, q the squared distance in the map (Veach and Guibas 1995, balance heuristic). Where lights are
   near, q is small and the second way takes over: its samples are dense there, so that no single one is bright. Any q
   that both sides compute alike leaves the sum unbiased; this one is log-radial density with its inner disc rounded
   off. */
static inline float rsm__mixed_scale(const rsm__gather *g, const rsm_map *map)
{
    /* density C / r^2 over a disc of unit radius with r_min = 1/192: C = 1 / (2 pi (log 192 + 1/2)); a cube's texel is
       1 / (6 side^2) of the disc's area pi */
    return (float)g->centred * 0.02764f * (map->faces == 1 ? 1.0f : 0.5236f) / ((float)map->size * (float)map->size);
}

#define RSM__MIXED_MIN (1.0f / 192.0f) /* r_min: small enough that texels about a corner are taken nearly one by one */
#define RSM__MIXED_INNER 2.7127e-5f  /* its square */

/* The place of texel (i, j) of a face: in the unit square, or on the sphere of diameter 1. */
static inline rsm__v3 rsm__mixed_place(const rsm_map *map, uint32_t face, uint32_t i, uint32_t j)
{
    float u = rsm__texel_centre(map, i), v = rsm__texel_centre(map, j);
    rsm__v3 r, up, a;
    if (map->faces == 1) return rsm__v3_make(u * 0.5f + 0.5f, v * 0.5f + 0.5f, 0.0f);
    rsm__face_frame(map, face, &r, &up, &a);
    return rsm__v3_scale(rsm__v3_normalize(rsm__v3_madd(rsm__v3_madd(a, r, u), up, v)), 0.5f);
}

/* Where patterns about a receiver have their centre: in the unit square, or a direction, with its frame. */
static inline rsm__v3 rsm__centre_of(const rsm_map *map, rsm__v3 p, int inside, rsm__v3 frame[2])
{
    rsm__v3 centre;
    if (map->faces != 1) {
        centre = rsm__v3_normalize(rsm__v3_sub(p, rsm__v3_load(map->desc.light.position)));
        if (!(rsm__v3_length(centre) > 0.5f)) centre = map->axis;
        rsm__v3_basis(centre, &frame[0], &frame[1]);
        return centre;
    }
    centre = rsm__to_face(map, 0, p);
    if (!rsm__is_sun(map) && !(centre.z > 0.0f)) centre = rsm__v3_make(0, 0, 0);
    centre = rsm__v3_make(centre.x * 0.5f + 0.5f, centre.y * 0.5f + 0.5f, 0.0f);
    if (inside) {                                /* any centre in the map will do, near ones do best */
        centre.x = centre.x > 0.02f ? centre.x < 0.98f ? centre.x : 0.98f : 0.02f;
        centre.y = centre.y > 0.02f ? centre.y < 0.98f ? centre.y : 0.98f : 0.02f;
    }
    return centre;
}

/* Texel number i of a map in tiles of 32 x 32 texels, a run each, of tiles of 8 x 8, a block each, so that near_field
   looks at few of them. (size_t)-1: in a tile, but outside the map. */
static inline size_t rsm__tiled_texel(const rsm_map *map, size_t i)
{
    size_t tiles = (map->size + 31u) / 32u, tile = i / 1024u, face = tile / (tiles * tiles);
    size_t x = tile % tiles * 32u + (i >> 6 & 3u) * 8u + (i & 7u);
    size_t y = tile / tiles % tiles * 32u + (i >> 8 & 3u) * 8u + (i >> 3 & 7u);
    return x < map->size && y < map->size ? (face * map->size + y) * map->size + x : (size_t)-1;
}

/* Of texels taken one by one: diffuse flux, or a lobe, which black ones may have too. */
static inline int rsm__gives_light(const rsm__gather *g, const rsm_texel *t)
{
    return rsm__mean3(t->flux) > 0.0f ||
           (t->material != 0 && t->material <= g->desc.material_count && t->depth < RSM_FAR);
}

static inline size_t rsm__count_texels(const rsm__gather *g, const rsm_map *map)
{
    size_t at, texels = rsm__texel_count(map), count = 0;
    if (!g->desc.materials) return (size_t)map->stats.lit_texels;
    for (at = 0; at < texels; at++) count += (size_t)rsm__gives_light(g, map->texels + at);
    return count;
}

/* Pixel lights of a map that all receivers share: blocks filled set by set, each set padded to whole blocks. */
static inline rsm_result rsm__pack_map(rsm__gather *g, rsm__source *s, const rsm__allocator *a)
{
    const rsm_map *map = s->map;
    size_t texels = rsm__texel_count(map), count = g->desc.samples ? g->shared : rsm__count_texels(g, map);
    size_t per_set = (count + g->sets - 1) / g->sets, i, at = 0, placed = 0, lanes;
    int nearby = g->desc.near_field > 0.0f && g->desc.samples == 0, tiled = nearby && g->sets == 1;
    if (tiled) texels = (size_t)map->faces * ((map->size + 31u) / 32u) * ((map->size + 31u) / 32u) * 1024u;
    s->set_blocks = (per_set + RSM__BLOCK - 1) / RSM__BLOCK;
    s->set_lights = per_set;
    s->set_lanes = (per_set + RSM__LANES - 1) / RSM__LANES * RSM__LANES;
    lanes = s->set_blocks * g->sets * RSM__BLOCK;
    if (count == 0) return RSM_OK;
    s->blocks = (rsm__block *)rsm__alloc_array(a, s->set_blocks * g->sets, sizeof *s->blocks);
    if (g->desc.materials) s->gloss = (rsm__gloss *)rsm__alloc_array(a, lanes, sizeof *s->gloss);
    if (!s->blocks || (g->desc.materials && !s->gloss)) return RSM_ERR_ALLOC;
    for (i = 0; i < lanes; i++) rsm__lane_clear(s->blocks + i / RSM__BLOCK, i % RSM__BLOCK);
    if (s->gloss) memset(s->gloss, 0, lanes * sizeof *s->gloss);
    for (i = 0; i < (g->desc.samples ? count : texels); i++) {
        size_t set, lane;
        float weight = 1.0f;
        if (g->desc.samples) {
            if (!rsm__pick_texel(map, (uint32_t)i, (uint32_t)count, g->desc.seed, &at, &weight)) continue;
        } else {
            at = tiled ? rsm__tiled_texel(map, i) : i;
            if (at == (size_t)-1 || !rsm__gives_light(g, map->texels + at)) continue;
        }
        set = rsm__hash_combine(g->desc.seed, (uint32_t)(placed / g->sets));
        set = (placed + set) % g->sets;          /* runs of neighbours go to all sets, each run in another order */
        lane = set * s->set_blocks * RSM__BLOCK + placed / g->sets;
        rsm__lane_set(&g->desc, s->blocks + lane / RSM__BLOCK, lane % RSM__BLOCK, map->texels + at, weight,
                      (float)g->sets);
        if (g->centred) {
            rsm__block *k = s->blocks + lane / RSM__BLOCK;
            size_t row = at / map->size;
            rsm__v3 place = rsm__mixed_place(map, (uint32_t)(row / map->size), (uint32_t)(at % map->size),
                                             (uint32_t)(row % map->size));
            k->lx[lane % RSM__BLOCK] = place.x;
            k->ly[lane % RSM__BLOCK] = place.y;
            k->lz[lane % RSM__BLOCK] = place.z;
            k->density[lane % RSM__BLOCK] = 1.0f / weight;
        }
        if (s->gloss) rsm__gloss_set(&g->desc, map, s->gloss + lane, at, weight * (float)g->sets);
        if (nearby) rsm__lane_near(&g->desc, map, s->blocks + lane / RSM__BLOCK, lane % RSM__BLOCK, at);
        placed++;
    }
    return nearby ? rsm__find_reaches(g, s, a) : RSM_OK;
}

static inline rsm_result rsm__pack_list(rsm__gather *g, rsm__source *s, const rsm_texel *lights, size_t count,
                                        const rsm__allocator *a)
{
    size_t i, per_set = (count + g->sets - 1) / g->sets, lanes;
    s->set_blocks = (per_set + RSM__BLOCK - 1) / RSM__BLOCK;
    s->set_lights = per_set;
    s->set_lanes = (per_set + RSM__LANES - 1) / RSM__LANES * RSM__LANES;
    lanes = s->set_blocks * g->sets * RSM__BLOCK;
    if (count == 0) return RSM_OK;
    s->blocks = (rsm__block *)rsm__alloc_array(a, s->set_blocks * g->sets, sizeof *s->blocks);
    if (!s->blocks) return RSM_ERR_ALLOC;
    for (i = 0; i < lanes; i++) rsm__lane_clear(s->blocks + i / RSM__BLOCK, i % RSM__BLOCK);
    for (i = 0; i < count; i++) {
        size_t lane = i % g->sets * s->set_blocks * RSM__BLOCK + i / g->sets;
        if (rsm__usable(rsm__v3_load(lights[i].position)) && rsm__usable(rsm__v3_load(lights[i].normal)) &&
            lights[i].flux[0] >= 0.0f && lights[i].flux[1] >= 0.0f && lights[i].flux[2] >= 0.0f &&
            rsm__mean3(lights[i].flux) <= 1e18f)
            rsm__lane_set(&g->desc, s->blocks + lane / RSM__BLOCK, lane % RSM__BLOCK, lights + i, 1.0f, (float)g->sets);
    }
    return RSM_OK;
}

/* Which texel is under a sample of a pattern about the receiver, and how many texels' worth it stands for; (size_t)-1
   where it is outside. centre: of the receiver's projection, in the unit square or, on a cube, a direction. place:
   NULL, or the texel's for MIXED. */
static inline size_t rsm__place_sample(const rsm_map *map, float r_max, rsm__v3 centre, const rsm__v3 frame[2],
                                       const float *sample, float c, float s, float *weight, rsm__v3 *place)
{
    float x = sample[0] * c - sample[1] * s, y = sample[0] * s + sample[1] * c, side = (float)map->size;
    uint32_t i, j, face = 0;
    if (map->faces == 1) {
        float r = r_max;
        if (!(r > 0.0f)) {                       /* to the border: the ray's length scales radius and area alike */
            float length = sqrtf(x * x + y * y), dx, dy;
            if (!(length > 0.0f)) length = 1.0f;
            dx = x / length;
            dy = y / length;
            dx = fabsf(dx) > 1e-9f ? (dx > 0.0f ? 1.0f - centre.x : centre.x) / fabsf(dx) : 4.0f;
            dy = fabsf(dy) > 1e-9f ? (dy > 0.0f ? 1.0f - centre.y : centre.y) / fabsf(dy) : 4.0f;
            r = dx < dy ? dx : dy;
        }
        x = (centre.x + r * x) * side;
        y = (centre.y + r * y) * side;
        *weight = sample[2] * r * r * side * side;
        if (!(r_max > 0.0f)) {                   /* rounding must not lose what ends on the border */
            x = x < 0.0f ? 0.0f : x >= side ? side - 0.5f : x;
            y = y < 0.0f ? 0.0f : y >= side ? side - 0.5f : y;
        }
        if (!(x >= 0.0f && x < side && y >= 0.0f && y < side)) return (size_t)-1;
        i = (uint32_t)x;
        j = (uint32_t)y;
    } else {                                     /* equal-area disc of the sphere: r = sin(angle / 2) */
        float r = r_max > 0.0f && r_max < 1.0f ? r_max : 1.0f, t, height, q, u, v;
        rsm__v3 d, a, right, up;
        x *= r;
        y *= r;
        t = x * x + y * y;
        height = 1.0f - 2.0f * t;
        q = 2.0f * sqrtf(t < 1.0f ? 1.0f - t : 0.0f);
        d = rsm__v3_madd(rsm__v3_madd(rsm__v3_scale(centre, height), frame[0], x * q), frame[1], y * q);
        face = rsm__cube_face(rsm__v3_dot(d, map->right), rsm__v3_dot(d, map->up), rsm__v3_dot(d, map->axis));
        if (face >= map->faces) return (size_t)-1;
        rsm__face_frame(map, face, &right, &up, &a);
        height = rsm__v3_dot(d, a);
        u = rsm__v3_dot(d, right) / height;
        v = rsm__v3_dot(d, up) / height;
        i = (uint32_t)((u * 0.5f + 0.5f) * side);
        j = (uint32_t)((v * 0.5f + 0.5f) * side);
        i = i < map->size ? i : map->size - 1u;
        j = j < map->size ? j : map->size - 1u;
        u = rsm__texel_centre(map, i);
        v = rsm__texel_centre(map, j);
        q = 1.0f + u * u + v * v;                /* solid angle of the texel: (2 / side)^2 / q^1.5 */
        *weight = sample[2] * 4.0f * r * r * 0.25f * side * side * q * sqrtf(q);
    }
    if (place) *place = rsm__mixed_place(map, face, i, j);
    return ((size_t)face * map->size + j) * map->size + i;
}

/* Pixel lights about one receiver. */
static inline void rsm__gather_centred(const rsm__gather *g, const rsm_map *map, const float x[7], uint32_t set,
                                       float noise, rsm__sum *sum)
{
    rsm__v3 frame[2], centre, middle, places[RSM__BLOCK];
    rsm__block block;
    size_t found[RSM__BLOCK];
    float weights[RSM__BLOCK], s = 0.0f, c = 1.0f, scale = rsm__mixed_scale(g, map);
    float total = (float)map->rows[(size_t)map->size * map->faces];
    uint32_t first, i, k, n;
    int nearby = g->desc.near_field > 0.0f;
    frame[0] = frame[1] = rsm__v3_make(0, 0, 0);
    if (g->desc.noise) rsm__sincos(noise * (2.0f * RSM__PI), &s, &c);
    centre = rsm__centre_of(map, rsm__v3_make(x[0], x[1], x[2]), !(g->desc.r_max > 0.0f), frame);
    middle = rsm__v3_scale(centre, map->faces == 1 ? 1.0f : 0.5f);
    for (first = 0; first < g->set_samples; first += RSM__BLOCK) {
        const float *pattern = g->pattern + 3 * ((size_t)set * g->set_samples + first);
        n = g->set_samples - first < RSM__BLOCK ? g->set_samples - first : (uint32_t)RSM__BLOCK;
        for (i = 0; i < n; i++) {                /* texels lie all over the map: all of them are asked for at first */
            found[i] = rsm__place_sample(map, g->desc.r_max, centre, frame, pattern + 3 * i, c, s, &weights[i],
                                         g->shared ? &places[i] : NULL);
            if (found[i] != (size_t)-1) RSM__PREFETCH(&map->texels[found[i]].flux);
        }
        for (i = 0; g->shared && i < n; i++) {
            rsm__v3 d;
            float q;
            if (found[i] == (size_t)-1) continue;
            d = rsm__v3_sub(places[i], middle);
            q = (rsm__v3_dot(d, d) + RSM__MIXED_INNER) * (float)g->shared * rsm__mean3(map->texels[found[i]].flux);
            if (total > 0.0f) weights[i] *= scale / (q / total + scale);
        }
        for (i = 0; i < n; i++)
            if (found[i] != (size_t)-1 && (g->desc.materials || rsm__mean3(map->texels[found[i]].flux) > 0.0f))
                rsm__lane_set(&g->desc, &block, i, map->texels + found[i], weights[i], (float)g->sets);
            else rsm__lane_clear(&block, i);
        for (; i % RSM__LANES; i++) rsm__lane_clear(&block, i);
        for (k = 0; nearby && k < n; k++)
            if (found[k] != (size_t)-1) rsm__lane_near(&g->desc, map, &block, k, found[k]);
        if (nearby) rsm__kernel_near(g, map, &block, i, x, sum);
        else g->kernel(&block, i, x, sum);
        for (i = 0; g->desc.materials && i < n; i++) {
            rsm__gloss gloss;
            if (found[i] == (size_t)-1 || map->texels[found[i]].material == 0) continue;
            rsm__gloss_set(&g->desc, map, &gloss, found[i], weights[i] * (float)g->sets);
            rsm__add_gloss(&gloss, &block, i, x,
                           nearby && rsm__is_near(&block, i, x) ? rsm__near_form(map, &block, i, x) : -1.0f, sum);
        }
    }
}

static inline void rsm__gather_shared(const rsm__gather *g, const rsm__source *s, const float x[7], uint32_t set,
                                      rsm__sum *sum)
{
    const rsm__block *blocks = s->blocks + set * s->set_blocks;
    const rsm__reach *runs = s->reaches ? s->reaches + s->set_blocks * g->sets + set * s->set_runs : NULL;
    rsm__block mixed;
    rsm__v3 frame[2], centre;
    float scale = 0.0f, mean;
    size_t i, k;
    centre = rsm__v3_make(0, 0, 0);
    if (g->centred && s->map) {
        centre = rsm__v3_scale(rsm__centre_of(s->map, rsm__v3_make(x[0], x[1], x[2]), 1, frame),
                               s->map->faces == 1 ? 1.0f : 0.5f);
        scale = rsm__mixed_scale(g, s->map);
    }
    for (i = 0; i < s->set_lanes && !(scale > 0.0f); i += RSM__RUN) {
        /* short sums keep their bits where lights are many */
        size_t lanes = s->set_lanes - i < RSM__RUN ? s->set_lanes - i : (size_t)RSM__RUN;
        if (runs && rsm__reaches(runs + i / RSM__RUN, x)) rsm__gather_near(g, s, set, i, lanes, x, sum);
        else g->kernel(blocks + i / RSM__BLOCK, lanes, x, sum);
    }
    for (i = 0; i < s->set_blocks && (scale > 0.0f || s->gloss); i++) {
        size_t lanes = s->set_lanes - i * RSM__BLOCK < RSM__BLOCK ? s->set_lanes - i * RSM__BLOCK : (size_t)RSM__BLOCK;
        if (scale > 0.0f) {
            mixed = blocks[i];
            for (k = 0; k < lanes; k++) {
                float dx = mixed.lx[k] - centre.x, dy = mixed.ly[k] - centre.y, dz = mixed.lz[k] - centre.z;
                float q = (dx * dx + dy * dy + dz * dz + RSM__MIXED_INNER) * mixed.density[k], w = q / (q + scale);
                mixed.r[k] *= w;
                mixed.g[k] *= w;
                mixed.b[k] *= w;
                mixed.density[k] = w;
            }
            g->kernel(&mixed, lanes, x, sum);
        }
        for (k = 0; s->gloss && k < lanes; k++) {
            rsm__gloss gloss = s->gloss[((size_t)set * s->set_blocks + i) * RSM__BLOCK + k];
            int c;
            if (!(gloss.scale[0] > 0.0f || gloss.scale[1] > 0.0f || gloss.scale[2] > 0.0f)) continue;
            for (c = 0; c < 3 && scale > 0.0f; c++) gloss.scale[c] *= mixed.density[k];
            mean = s->reaches && rsm__is_near(blocks + i, k, x) ? rsm__near_form(s->map, blocks + i, k, x) : -1.0f;
            rsm__add_gloss(&gloss, blocks + i, k, x, mean, sum);
        }
    }
}

/* Share of a map's flux that lies beyond r_max of the receiver. */
static inline double rsm__outside_share(const rsm_map *map, float r_max, rsm__v3 p)
{
    double outside = 0.0, total = map->rows[(size_t)map->size * map->faces];
    size_t at, face = (size_t)map->size * map->size, count = rsm__texel_count(map);
    rsm__v3 q = rsm__to_face(map, 0, p), centre;
    if (!(total > 0.0)) return 0.0;
    centre = rsm__v3_normalize(rsm__v3_sub(p, rsm__v3_load(map->desc.light.position)));
    if (map->faces == 1 && !rsm__is_sun(map) && !(q.z > 0.0f)) q = rsm__v3_make(0, 0, 0);
    for (at = 0; at < count; at++) {
        float u = rsm__texel_centre(map, (uint32_t)(at % map->size)), v, f = rsm__mean3(map->texels[at].flux), d;
        v = rsm__texel_centre(map, (uint32_t)(at % face / map->size));
        if (!(f > 0.0f)) continue;
        if (map->faces == 1) d = 0.25f * ((u - q.x) * (u - q.x) + (v - q.y) * (v - q.y));
        else {
            rsm__v3 there = rsm__from_face(map, (uint32_t)(at / face), u, v, 1.0f);
            there = rsm__v3_normalize(rsm__v3_sub(there, rsm__v3_load(map->desc.light.position)));
            d = 0.5f * (1.0f - rsm__v3_dot(there, centre));
        }
        if (d > r_max * r_max) outside += (double)f;
    }
    return outside / total;
}

static inline void rsm__write_sum(const rsm__gather *g, size_t at, const float rgb[3])
{
    const rsm_points *p = g->points;
    float occlusion = 1.0f, *out = g->out + 3 * at;
    int c;
    if (p->occlusion) occlusion = *rsm__at(p->occlusion, rsm__stride(p->occlusion_stride, 4), at);
    occlusion = occlusion > 0.0f ? occlusion < 1.0f ? occlusion : 1.0f : 0.0f;
    for (c = 0; c < 3; c++) out[c] = (g->desc.add ? out[c] : 0.0f) + rgb[c] * g->scale * occlusion;
}

static inline void rsm__gather_one(const rsm__gather *g, size_t number, rsm__tally *tally, int wants_share)
{
    const rsm_points *p = g->points;
    size_t at = p->indices ? p->indices[number] : number, i, px = p->width ? at % p->width : at;
    size_t py = p->width ? at / p->width : 0;
    uint32_t k = g->desc.interleave, set = (uint32_t)(px % k + k * (py % k));
    float x[7], noise = 0.0f, *out = g->out + 3 * at;
    rsm__sum sum = { { 0, 0, 0 }, 0, 0, 0 };
    rsm__v3 position, normal;
    int c;
    if (!rsm__receiver(p, at, &position, &normal, &tally->bad)) {
        for (c = 0; c < 3 && !g->desc.add; c++) out[c] = 0.0f;
        return;
    }
    if (g->desc.noise) noise = g->desc.noise[py % g->desc.noise_side * g->desc.noise_side + px % g->desc.noise_side];
    rsm__v3_store(x, position);
    rsm__v3_store(x + 3, normal);
    x[6] = rsm__rounding(x[0], x[1], x[2]);
    for (i = 0; i < g->source_count; i++) {
        const rsm__source *s = g->sources + i;
        if (s->blocks) rsm__gather_shared(g, s, x, set, &sum);
        if (s->map && g->pattern) rsm__gather_centred(g, s->map, x, set, noise, &sum);
        if (s->map && g->pattern && wants_share && g->desc.r_max > 0.0f) {
            tally->outside += rsm__outside_share(s->map, g->desc.r_max, position);
            tally->looked += 1.0;
        }
        tally->pairs += (s->blocks ? s->set_lanes : 0) + g->set_samples;
    }
    if (g->reach2) g->reach2[at] = 1.0f / (sum.nearby > 1e-30f ? sum.nearby : 1e-30f);
    tally->evaluated++;
    tally->full += (double)sum.full;
    tally->lost += (double)sum.lost;
    rsm__write_sum(g, at, sum.rgb);
}

static inline void rsm__gather_batch(void *context, size_t batch)
{
    const rsm__gather *g = (const rsm__gather *)context;
    rsm__tally *tally = g->tallies + batch;
    size_t i, first = batch * RSM__BATCH, end = first + RSM__BATCH < g->count ? first + RSM__BATCH : g->count;
    size_t every = g->count / 64 + 1;
    memset(tally, 0, sizeof *tally);
    for (i = first; i < end; i++) rsm__gather_one(g, i, tally, i % every == 0);
}

/* Interleaved pictures: pixels of a row that take the same set are gathered for together, as many as lanes. */
static inline int rsm__takes_rows(const rsm__gather *g)
{
    size_t i;
    if (g->sets == 1 || g->pattern || g->desc.materials || g->points->width == 0 || g->points->indices) return 0;
    for (i = 0; i < g->source_count; i++)          /* sums of more lights would lose bits, and have lanes enough */
        if (g->sources[i].reaches || g->sources[i].set_lanes > RSM__FEW) return 0;
    return 1;
}

static inline void rsm__crowd_add(const rsm__gather *g, rsm__crowd *p, size_t at, rsm__tally *tally)
{
    rsm__v3 position, normal;
    float x[6];
    int c;
    if (!rsm__receiver(g->points, at, &position, &normal, &tally->bad)) {
        for (c = 0; c < 3 && !g->desc.add; c++) g->out[3 * at + (size_t)c] = 0.0f;
        return;
    }
    rsm__v3_store(x, position);
    rsm__v3_store(x + 3, normal);
    for (c = 0; c < 6; c++) p->x[c][p->count] = x[c];
    p->x[6][p->count] = rsm__rounding(x[0], x[1], x[2]);
    p->at[p->count++] = at;
}

static inline void rsm__crowd_gather(const rsm__gather *g, rsm__crowd *p, uint32_t set, rsm__tally *tally)
{
    size_t i, l;
    float rgb[3];
    int c;
    for (i = 0; i < g->source_count && p->count; i++) {
        const rsm__source *s = g->sources + i;
        if (s->blocks) g->crowd_kernel(s->blocks + set * s->set_blocks, s->set_lights, p);
        tally->pairs += (s->blocks ? s->set_lanes : 0) * p->count;
    }
    for (l = 0; l < p->count; l++) {
        for (c = 0; c < 3; c++) rgb[c] = p->sums[c][l];
        rsm__write_sum(g, p->at[l], rgb);
        tally->evaluated++;
        tally->full += (double)p->sums[3][l];
        tally->lost += (double)p->sums[4][l];
    }
    memset(p, 0, sizeof *p);
}

static inline void rsm__gather_row(void *context, size_t y)
{
    const rsm__gather *g = (const rsm__gather *)context;
    rsm__tally *tally = g->tallies + y;
    size_t width = g->points->width, first = y * width, n = g->count - first < width ? g->count - first : width, x;
    uint32_t k = g->desc.interleave, column;
    rsm__crowd p;
    memset(tally, 0, sizeof *tally);
    memset(&p, 0, sizeof p);
    for (column = 0; column < k; column++) {
        uint32_t set = column + k * (uint32_t)(y % k);
        for (x = column; x < n; x += k) {
            rsm__crowd_add(g, &p, first + x, tally);
            if (p.count == g->crowd_lanes) rsm__crowd_gather(g, &p, set, tally);
        }
        rsm__crowd_gather(g, &p, set, tally);
    }
}

static inline rsm_result rsm__gather_check(const rsm_gather_desc *d, const rsm_points *points, rsm_gather_desc *out)
{
    uint32_t i;
    int c;
    *out = *d;
    if ((int)d->pattern < 0 || d->pattern >= RSM_PATTERN_COUNT || d->samples > RSM__MAX_SAMPLES) return RSM_ERR_DESC;
    if (d->pattern == RSM_PATTERN_DEFAULT) out->pattern = RSM_PATTERN_FLUX;
    if (d->pattern == RSM_PATTERN_POISSON && d->samples > RSM__MAX_POISSON) return RSM_ERR_DESC;
    if (!(d->r_max >= 0.0f && d->r_max <= 1e3f) || !(d->r_min >= 0.0f && d->r_min < 1.0f)) return RSM_ERR_DESC;
    if (!(d->r_min > 0.0f)) out->r_min = 1.0f / 32.0f;
    if (d->pattern == RSM_PATTERN_MIXED) out->r_min = RSM__MIXED_MIN;
    if (d->pattern == RSM_PATTERN_MIXED) out->r_max = 0.0f;
    if (!(d->offset >= 0.0f && d->offset <= 1e9f) || !(d->clamp >= 0.0f && d->clamp <= 1e18f)) return RSM_ERR_DESC;
    if (!(d->near_limit >= 0.0f && d->near_limit <= 1e6f)) return RSM_ERR_DESC;
    if (!(d->near_field >= 0.0f && d->near_field <= 32.0f)) return RSM_ERR_DESC;
    if (d->noise && (d->noise_side == 0 || d->noise_side > 4096)) return RSM_ERR_DESC;
    for (i = 0; d->noise && i < d->noise_side * d->noise_side; i++)
        if (!(d->noise[i] >= 0.0f && d->noise[i] <= 1.0f)) return RSM_ERR_DESC;
    if (d->interleave == 0) out->interleave = 1;
    if (out->interleave > 8 || (out->interleave & (out->interleave - 1))) return RSM_ERR_DESC;
    if (out->interleave > 1 && points->width == 0) return RSM_ERR_DESC;     /* one row: most sets would go to nobody */
    if (!d->materials && d->material_count) return RSM_ERR_DESC;
    for (i = 0; i < d->material_count; i++) {
        if (!(d->materials[i].exponent >= 0.0f && d->materials[i].exponent <= 1e4f)) return RSM_ERR_DESC;
        for (c = 0; c < 3; c++)
            if (!(d->materials[i].specular[c] >= 0.0f && d->materials[i].specular[c] <= 1.0f)) return RSM_ERR_DESC;
    }
    return rsm__system_valid(&d->system) ? RSM_OK : RSM_ERR_DESC;
}

static inline void rsm__gather_close(rsm__gather *g, const rsm__allocator *a)
{
    size_t i = g->sources ? g->source_count : 0;
    rsm__free(a, g->tallies);
    rsm__free(a, g->pattern);
    while (i-- > 0) {
        rsm__free(a, g->sources[i].reaches);
        rsm__free(a, g->sources[i].gloss);
        rsm__free(a, g->sources[i].blocks);
    }
    rsm__free(a, g->sources);
}

/* What all receivers share. On failure the caller closes. */
static inline rsm_result rsm__gather_open(rsm__gather *g, const rsm_map *const *maps, size_t map_count,
                                          const rsm_texel *lights, size_t light_count, const rsm__allocator *a)
{
    size_t i;
    int list = maps == NULL, mixed = g->desc.pattern == RSM_PATTERN_MIXED && g->desc.samples > 1;
    rsm_result result = RSM_OK;
    g->source_count = list ? 1 : map_count;
    g->sets = g->desc.interleave * g->desc.interleave;
    g->scale = 1.0f / RSM__PI;
    g->shared = g->centred = g->set_samples = 0;
    if (!list && g->desc.samples) {
        g->centred = mixed ? 3u * g->desc.samples / 5u : g->desc.samples;
        if (g->desc.pattern == RSM_PATTERN_FLUX || (g->desc.pattern == RSM_PATTERN_MIXED && !mixed)) g->centred = 0;
        g->shared = g->desc.samples - g->centred;
    }
    g->sources = (rsm__source *)rsm__alloc_array(a, g->source_count, sizeof *g->sources);
    if (!g->sources) return RSM_ERR_ALLOC;
    memset(g->sources, 0, g->source_count * sizeof *g->sources);
    if (g->centred) {
        uint32_t n, k;
        float *sorted;
        g->set_samples = (g->centred + g->sets - 1) / g->sets;
        n = g->set_samples * g->sets;            /* rounded up to equal sets: every sample weighs the same.
                                                    RSM__MAX_POISSON is a multiple of all of them */
        g->pattern = (float *)rsm__alloc_array(a, n, 3 * sizeof *g->pattern);
        sorted = (float *)rsm__alloc_array(a, n, 3 * sizeof *sorted);
        if (!g->pattern || !sorted) {
            rsm__free(a, sorted);
            return RSM_ERR_ALLOC;
        }
        g->centred = n;
        rsm__pattern_make(mixed ? RSM_PATTERN_LOG_RADIAL : g->desc.pattern, n, g->desc.r_min, g->desc.paper_weights,
                          g->desc.seed, sorted);
        for (k = 0; k < n; k++) {                /* sample k to set k % sets */
            float *to = g->pattern + 3 * ((size_t)(k % g->sets) * g->set_samples + k / g->sets);
            memcpy(to, sorted + 3 * (size_t)k, 3 * sizeof *to);
        }
        rsm__free(a, sorted);
    }
    for (i = 0; i < g->source_count && result == RSM_OK; i++) {
        if (!list) g->sources[i].map = maps[i];
        if (list) result = rsm__pack_list(g, g->sources, lights, light_count, a);
        else if (g->shared || !g->desc.samples) result = rsm__pack_map(g, g->sources + i, a);
    }
    return result;
}

static inline void rsm__gather_add_stats(const rsm__gather *g, size_t batches, rsm_gather_stats *stats, double sums[4])
{
    size_t i;
    for (i = 0; i < batches; i++) {
        stats->evaluated += g->tallies[i].evaluated;
        stats->pairs += g->tallies[i].pairs;
        stats->bad_points += g->tallies[i].bad;
        sums[0] += g->tallies[i].full;
        sums[1] += g->tallies[i].lost;
        sums[2] += g->tallies[i].outside;
        sums[3] += g->tallies[i].looked;
    }
    stats->clamped_share = sums[0] > 0.0 ? sums[1] / sums[0] : 0.0;
    stats->outside_share = sums[3] > 0.0 ? sums[2] / sums[3] : 0.0;
}

static inline rsm_result rsm__maps_check(const rsm_map *const *maps, size_t map_count)
{
    size_t i;
    if (!maps || map_count == 0) return RSM_ERR_ARGUMENT;
    for (i = 0; i < map_count; i++)
        if (!maps[i]) return RSM_ERR_ARGUMENT;
    for (i = 0; i < map_count; i++)
        if (!maps[i]->finished) return RSM_ERR_ORDER;
    return RSM_OK;
}

static inline size_t rsm__batches(const rsm__gather *g, size_t count)
{
    size_t each = rsm__takes_rows(g) ? g->points->width : (size_t)RSM__BATCH;
    return count / each + (count % each != 0);
}

/* Of an opened gather: room for the tallies of all of g->points. The caller closes. */
static inline rsm_result rsm__make_tallies(rsm__gather *g, const rsm__allocator *a)
{
    size_t batches = rsm__batches(g, g->points->indices ? g->points->index_count : g->points->count);
    g->tallies = (rsm__tally *)rsm__alloc_array(a, batches + 1, sizeof *g->tallies);
    return g->tallies ? RSM_OK : RSM_ERR_ALLOC;
}

/* The receivers of g->points. begin..end: what of the whole this is. */
static inline rsm_result rsm__gather_points(rsm__gather *g, rsm_gather_stats *stats, float begin, float end)
{
    size_t batches;
    rsm_gather_stats s;
    double sums[4] = { 0, 0, 0, 0 };
    g->count = g->points->indices ? g->points->index_count : g->points->count;
    batches = rsm__batches(g, g->count);
    if (!rsm__run_steps(&g->desc.system, batches, rsm__takes_rows(g) ? rsm__gather_row : rsm__gather_batch, g, begin,
                        end))
        return RSM_ERR_CANCELLED;
    if (!stats) return RSM_OK;
    memset(&s, 0, sizeof s);
    rsm__gather_add_stats(g, batches, &s, sums);
    *stats = s;
    return RSM_OK;
}

static inline int rsm__loss_wanted(const rsm__gather *g, const rsm_gather_stats *stats)
{
    return stats && (g->desc.clamp > 0.0f || g->desc.near_limit > 0.0f);
}

static inline rsm_result rsm__gather_run(rsm__gather *g, const rsm_map *const *maps, size_t map_count,
                                         const rsm_texel *lights, size_t light_count, rsm_gather_stats *stats)
{
    rsm__allocator a = rsm__allocator_of(&g->desc.system);
    rsm_result result;
    g->kernel = rsm__choose_kernel(rsm__loss_wanted(g, stats), 0);
    g->crowd_kernel = rsm__choose_crowd(rsm__loss_wanted(g, stats), &g->crowd_lanes);
    result = rsm__gather_open(g, maps, map_count, lights, light_count, &a);
    if (result == RSM_OK) result = rsm__make_tallies(g, &a);
    if (result == RSM_OK) result = rsm__gather_points(g, stats, 0.0f, 1.0f);
    rsm__gather_close(g, &a);
    return result;
}

RSM_DEF rsm_result rsm_gather(const rsm_map *const *maps, size_t map_count, const rsm_gather_desc *desc,
                              const rsm_points *points, float *irradiance, rsm_gather_stats *stats)
{
    rsm__gather g;
    rsm_result result = rsm__maps_check(maps, map_count);
    if (result != RSM_OK) return result;
    memset(&g, 0, sizeof g);
    if (!desc || !rsm__points_valid(points) || (!irradiance && points->count)) return RSM_ERR_ARGUMENT;
    result = rsm__gather_check(desc, points, &g.desc);
    if (result != RSM_OK) return result;
    g.points = points;
    g.out = irradiance;
    return rsm__gather_run(&g, maps, map_count, NULL, 0, stats);
}

RSM_DEF rsm_result rsm_gather_list(const rsm_texel *lights, size_t count, const rsm_gather_desc *desc,
                                   const rsm_points *points, float *irradiance, rsm_gather_stats *stats)
{
    rsm__gather g;
    rsm_result result;
    memset(&g, 0, sizeof g);
    if ((!lights && count) || !desc || !rsm__points_valid(points) || (!irradiance && points->count))
        return RSM_ERR_ARGUMENT;
    result = rsm__gather_check(desc, points, &g.desc);
    if (result != RSM_OK) return result;
    g.desc.materials = NULL;
    g.desc.noise = NULL;
    g.points = points;
    g.out = irradiance;
    return rsm__gather_run(&g, NULL, 0, lights, count, stats);
}

/* ---- >>lists and clusters ---- */

RSM_DEF rsm_result rsm_pixel_lights(const rsm_map *const *maps, size_t map_count, uint32_t samples, uint32_t seed,
                                    rsm_texel *lights, size_t capacity, size_t *count)
{
    size_t m, i, needed = 0, at = 0;
    rsm_result result = rsm__maps_check(maps, map_count);
    if (result != RSM_OK) return result;
    if (!count || (!lights && capacity) || samples > RSM__MAX_SAMPLES) return RSM_ERR_ARGUMENT;
    for (m = 0; m < map_count; m++) {
        float weight;
        if (!samples) needed += (size_t)maps[m]->stats.lit_texels;
        for (i = 0; i < samples; i++)
            needed += (size_t)rsm__pick_texel(maps[m], (uint32_t)i, samples, seed, &at, &weight);
    }
    *count = needed;
    if (capacity < needed) return RSM_ERR_MEMORY;
    for (m = 0, needed = 0; m < map_count; m++)
        for (i = 0; i < (samples ? samples : rsm__texel_count(maps[m])); i++) {
            float weight = 1.0f;
            int c;
            at = i;
            if (samples ? !rsm__pick_texel(maps[m], (uint32_t)i, samples, seed, &at, &weight)
                        : !(rsm__mean3(maps[m]->texels[at].flux) > 0.0f))
                continue;
            lights[needed] = maps[m]->texels[at];
            lights[needed].area *= weight;
            for (c = 0; c < 3; c++) lights[needed].flux[c] *= weight;
            needed++;
        }
    return RSM_OK;
}

/* A group of lights: the run first..first+count of the order. */
typedef struct rsm__group { size_t first, count; double flux, mean[6], spread[6], cost; } rsm__group;

static inline float rsm__coordinate(const rsm_texel *t, int k) { return k < 3 ? t->position[k] : t->normal[k - 3]; }

/* Mean and spread of position and normal by flux. cost: flux x spread, normals counted against size^2 of the scene. */
static inline void rsm__measure(rsm__group *g, const rsm_texel *lights, const uint32_t *order, double size2)
{
    size_t i;
    int k;
    g->flux = g->cost = 0.0;
    for (k = 0; k < 6; k++) g->mean[k] = g->spread[k] = 0.0;
    for (i = 0; i < g->count; i++) {
        const rsm_texel *t = lights + order[g->first + i];
        double f = (double)rsm__mean3(t->flux);
        g->flux += f;
        for (k = 0; k < 6; k++) {
            double v = (double)rsm__coordinate(t, k);
            g->mean[k] += f * v;
            g->spread[k] += f * v * v;
        }
    }
    for (k = 0; k < 6 && g->flux > 0.0; k++) {
        g->mean[k] /= g->flux;
        g->spread[k] = (g->spread[k] / g->flux - g->mean[k] * g->mean[k]) * (k < 3 ? 1.0 : 0.25 * size2);
        if (!(g->spread[k] > 0.0)) g->spread[k] = 0.0;
        g->cost += g->spread[k] * g->flux;
    }
    if (g->count < 2) g->cost = 0.0;
}

/* Cuts a group at the mean of its widest coordinate; returns 0 where all lights fall on one side. */
static inline int rsm__cut(rsm__group *g, rsm__group *other, const rsm_texel *lights, uint32_t *order, double size2)
{
    size_t low = g->first, high = g->first + g->count;
    int k, widest = 0;
    for (k = 1; k < 6; k++)
        if (g->spread[k] > g->spread[widest]) widest = k;
    while (low < high) {
        uint32_t swap = order[low];
        if ((double)rsm__coordinate(lights + swap, widest) < g->mean[widest]) low++;
        else {
            order[low] = order[--high];
            order[high] = swap;
        }
    }
    if (low == g->first || low == g->first + g->count) return 0;
    other->first = low;
    other->count = g->first + g->count - low;
    g->count = low - g->first;
    rsm__measure(g, lights, order, size2);
    rsm__measure(other, lights, order, size2);
    return 1;
}

static inline void rsm__group_light(const rsm__group *g, const rsm_texel *lights, const uint32_t *order, rsm_texel *out)
{
    double flux[3] = { 0, 0, 0 }, area = 0.0;
    const rsm_texel *brightest = lights + order[g->first];
    rsm__v3 normal = rsm__v3_make((float)g->mean[3], (float)g->mean[4], (float)g->mean[5]);
    size_t i;
    int c;
    rsm__texel_clear(out);
    for (i = 0; i < g->count; i++) {
        const rsm_texel *t = lights + order[g->first + i];
        if (rsm__mean3(t->flux) > rsm__mean3(brightest->flux)) brightest = t;
        for (c = 0; c < 3; c++) flux[c] += (double)t->flux[c];
        area += (double)t->area;
    }
    for (c = 0; c < 3; c++) {
        out->position[c] = (float)g->mean[c];
        out->flux[c] = (float)flux[c];
    }
    out->area = (float)area;
    out->depth = 0.0f;
    if (!(rsm__v3_length(normal) > 1e-6f)) normal = rsm__v3_load(brightest->normal);    /* opposite ones cancel out */
    rsm__v3_store(out->normal, rsm__v3_normalize(normal));
}

RSM_DEF rsm_result rsm_cluster(const rsm_texel *lights, size_t light_count, uint32_t cluster_count,
                               const rsm_system *system, rsm_texel *clusters, size_t *count)
{
    rsm_system none;
    rsm__allocator a;
    rsm__group *groups;
    uint32_t *order, found = 1, i, k, most;
    size_t used = 0, at;
    double size2 = 0.0;
    memset(&none, 0, sizeof none);
    if (!system) system = &none;
    if ((!lights && light_count) || !clusters || !count || cluster_count == 0 || cluster_count > 65536u ||
        light_count > 0x7fffffffu)
        return RSM_ERR_ARGUMENT;
    if (!rsm__system_valid(system)) return RSM_ERR_ARGUMENT;
    a = rsm__allocator_of(system);
    order = (uint32_t *)rsm__alloc_array(&a, light_count + 1, sizeof *order);
    groups = (rsm__group *)rsm__alloc_array(&a, cluster_count, sizeof *groups);
    if (!order || !groups) {
        rsm__free(&a, groups);
        rsm__free(&a, order);
        return RSM_ERR_ALLOC;
    }
    for (at = 0; at < light_count; at++) {
        float f = rsm__mean3(lights[at].flux);
        if (f > 0.0f && f <= 1e18f && rsm__usable(rsm__v3_load(lights[at].position)) &&
            rsm__usable(rsm__v3_load(lights[at].normal)))
            order[used++] = (uint32_t)at;
    }
    groups[0].first = 0;
    groups[0].count = used;
    rsm__measure(groups, lights, order, 0.0);
    for (k = 0; k < 3; k++) size2 += groups[0].spread[k];
    rsm__measure(groups, lights, order, size2);
    while (used && found < cluster_count) {
        most = 0;
        for (i = 1; i < found; i++)
            if (groups[i].cost > groups[most].cost) most = i;
        if (!(groups[most].cost > 0.0)) break;
        if (rsm__cut(groups + most, groups + found, lights, order, size2)) found++;
        else groups[most].cost = 0.0;
    }
    for (i = 0; used && i < found; i++) rsm__group_light(groups + i, lights, order, clusters + i);
    *count = used ? found : 0;
    rsm__free(&a, groups);
    rsm__free(&a, order);
    return RSM_OK;
}

/* ---- >>interpolation ---- */

/* Open pixels of one cell in arrays, so that the tests of section 4 run in vectors: cells of 8 and 4 fill them, the
   three of a cell of 2 fill three of four lanes. */
enum { RSM__TILE = 128 };

typedef struct rsm__tile {
    float    px[RSM__TILE], py[RSM__TILE], pz[RSM__TILE], nx[RSM__TILE], ny[RSM__TILE], nz[RSM__TILE];
    int32_t  good[RSM__TILE];      /* bits of the samples that suit */
    uint32_t x[RSM__TILE], y[RSM__TILE];
} rsm__tile;

/* Is the sample good for a pixel? s: its position and normal; limits: of the cosine, slope^2, distance^2. */
#define RSM__SUIT_LANES(lanes)                                                                               \
    for (l = 0; l < (lanes); l++) {                                                                          \
        float dx = s[0] - t->px[i + l], dy = s[1] - t->py[i + l], dz = s[2] - t->pz[i + l];                  \
        float nx = t->nx[i + l], ny = t->ny[i + l], nz = t->nz[i + l], d2 = dx * dx + dy * dy + dz * dz;     \
        float plane = dx * nx + dy * ny + dz * nz, other = dx * s[3] + dy * s[4] + dz * s[5], most = limits[1] * d2; \
        int32_t fits = (s[3] * nx + s[4] * ny + s[5] * nz >= limits[0]) & (plane * plane <= most) &          \
                       (other * other <= most) & (d2 <= limits[2]);                                          \
        t->good[i + l] |= fits ? bit : 0;                                                                    \
    }

/* count: a multiple of 4. */
#define RSM__SUIT_BODY                                                                                       \
    size_t i = 0, l;                                                                                         \
    for (; i + 4 < count; i += 8) { RSM__SUIT_LANES(8) }                                                     \
    if (i < count) { RSM__SUIT_LANES(4) }

typedef void (*rsm__suit)(rsm__tile *t, size_t count, const float s[6], const float limits[3], int32_t bit);

RSM__HOT static void rsm__suit_plain(rsm__tile *t, size_t count, const float s[6], const float limits[3],
                                     int32_t bit){ RSM__SUIT_BODY }

#if RSM__X86
RSM__TARGET_AVX2 RSM__HOT
    static void rsm__suit_avx2(rsm__tile *t, size_t count, const float s[6], const float limits[3], int32_t bit)
{
    RSM__SUIT_BODY
}
#endif

static inline rsm__suit rsm__choose_suit(void)
{
#if RSM__X86
    if (rsm__cpu_has_avx2()) return rsm__suit_avx2;
#endif
    return rsm__suit_plain;
}

typedef struct rsm__grid {
    const rsm_points       *points;
    const rsm_interpolation *desc;
    float    *out;
    uint8_t  *state;               /* of each pixel */
    uint32_t *list;                /* pixels to evaluate */
    uint32_t  width, height, step;
    int       lossy;
    rsm__suit suit;
    float    *reach2;              /* of samples: squared distance of the nearest light */
    float     limits[3];           /* least cosine, largest slope^2 and distance^2 of a sample that suits */
} rsm__grid;

/* States of pixels. What is still open has bit 0 and no other state has, so that cells are asked eight pixels at a
 * time. */
enum {
    RSM__NONE = 0, RSM__BAD = 2,            /* no receiver there; not finite */
    RSM__OPEN = 1, RSM__WANTED = 3,
    RSM__INTERPOLATED = 4, RSM__REPLACED = 6, /* wanted, interpolated before */
    RSM__EVALUATED = 8
};

/* Grid lines of a coordinate: multiples of step, a power of two, and the picture's last pixel. */
static inline void rsm__grid_lines(uint32_t at, uint32_t step, uint32_t size, uint32_t line[2])
{
    line[0] = at & ~(step - 1u);
    line[1] = line[0] + step < size ? line[0] + step : size - 1;
}

static inline float rsm__grid_share(uint32_t at, const uint32_t line[2])
{
    return line[1] > line[0] ? (float)(at - line[0]) / (float)(line[1] - line[0]) : 0.0f;
}

enum { RSM__ALL_SUIT = 4 };        /* "the missing sample" of a pixel that has all four */

typedef struct rsm__cell {
    uint32_t column[2], row[2];
    float    samples[4][6];        /* positions and normals of the corners */
    float    rgb[4][3], limits[4][3];
    int      there;                /* bits of the corners that were evaluated */
    int      agree[5];             /* by the missing sample: do the others? */
} rsm__cell;

/* Are the corners there, but for the missing one, and alike? */
static inline int rsm__corners_agree(int there, const float mean[4], int missing, float contrast)
{
    float low = RSM_FAR, high = 0.0f, sum = 0.0f;
    int k;
    if ((there | (missing < 4 ? 1 << missing : 0)) != 15) return 0;
    for (k = 0; k < 4; k++) {
        if (k == missing) continue;
        low = mean[k] < low ? mean[k] : low;
        high = mean[k] > high ? mean[k] : high;
        sum += mean[k];
    }
    return !(contrast >= 0.0f && high - low > contrast * sum / (missing < 4 ? 3.0f : 4.0f));
}

/* 0: the cell does for no pixel. */
static inline int rsm__cell_load(const rsm__grid *g, rsm__cell *cell)
{
    const rsm_points *p = g->points;
    size_t at[4];
    float mean[4];
    int k, any = 0;
    cell->there = 0;
    for (k = 0; k < 4; k++) {
        at[k] = (size_t)cell->row[k >> 1] * g->width + cell->column[k & 1];
        mean[k] = 0.0f;
        if (g->state[at[k]] != RSM__EVALUATED) continue;
        mean[k] = rsm__mean3(g->out + 3 * at[k]);
        cell->there |= 1 << k;
    }
    for (k = 0; k <= RSM__ALL_SUIT; k++)
        any |= cell->agree[k] = rsm__corners_agree(cell->there, mean, k, g->desc->contrast);
    for (k = 0; k < 4 && any; k++) {
        memcpy(cell->samples[k], rsm__at(p->positions, rsm__stride(p->position_stride, 12), at[k]), 12);
        memcpy(cell->samples[k] + 3, rsm__at(p->normals, rsm__stride(p->normal_stride, 12), at[k]), 12);
        memcpy(cell->rgb[k], g->out + 3 * at[k], 12);
        memcpy(cell->limits[k], g->limits, sizeof g->limits);
        if (g->desc->reach > 0.0f && g->reach2[at[k]] * g->desc->reach * g->desc->reach < cell->limits[k][2])
            cell->limits[k][2] = g->reach2[at[k]] * g->desc->reach * g->desc->reach;
    }
    return any;
}

/* A missing fourth is completed to a plane, the sum of its neighbours less the one across: the paper's normalised
   weights pull the result towards the other three, 6 % at a crease (T39). */
static inline void rsm__cell_value(const rsm__cell *cell, int missing, float u, float v, float *out)
{
    float w[4];
    int c;
    w[0] = (1.0f - v) * (1.0f - u);
    w[1] = (1.0f - v) * u;
    w[2] = v * (1.0f - u);
    w[3] = v * u;
    if (missing < 4) {
        w[missing ^ 1] += w[missing];
        w[missing ^ 2] += w[missing];
        w[missing ^ 3] -= w[missing];
        w[missing] = 0.0f;
    }
    for (c = 0; c < 3; c++) {
        float x = w[0] * cell->rgb[0][c] + w[1] * cell->rgb[1][c] + w[2] * cell->rgb[2][c] + w[3] * cell->rgb[3][c];
        out[c] = x > 0.0f ? x : 0.0f;
    }
}

/* Section 4's rule for the pixels of a tile: three samples of four, or all, bilinear. */
static inline void rsm__tile_interpolate(rsm__grid *g, const rsm__cell *cell, rsm__tile *t, size_t count)
{
    size_t i, end = (count + 3) & ~(size_t)3;
    int k;
    for (i = count; i < end; i++) t->px[i] = t->py[i] = t->pz[i] = t->nx[i] = t->ny[i] = t->nz[i] = 0.0f;
    memset(t->good, 0, end * sizeof *t->good);
    for (k = 0; k < 4; k++)
        if (cell->there >> k & 1) g->suit(t, end, cell->samples[k], cell->limits[k], 1 << k);
    for (i = 0; i < count; i++) {
        static const int8_t missing_of[16] = { -1, -1, -1, -1, -1, -1, -1, 3, -1, -1, -1, 2, -1, 1, 0, RSM__ALL_SUIT };
        size_t at = (size_t)t->y[i] * g->width + t->x[i];
        int missing = missing_of[t->good[i]];
        if (missing < 0 || !cell->agree[missing]) continue;
        rsm__cell_value(cell, missing, rsm__grid_share(t->x[i], cell->column), rsm__grid_share(t->y[i], cell->row),
                        g->out + 3 * at);
        g->state[at] = RSM__INTERPOLATED;
    }
}

/* Are there pixels that nothing did for yet? */
static inline int rsm__cell_open(const rsm__grid *g, uint32_t left, uint32_t top, uint32_t right, uint32_t bottom)
{
    const uint64_t bits = 0x0101010101010101u;
    uint32_t x, y;
    for (y = top; y < bottom; y++) {
        const uint8_t *s = g->state + (size_t)y * g->width;
        for (x = left; x < right;) {
            uint64_t some = 0;
            if (right - x >= 8) memcpy(&some, s + x, 8);
            else if (right - x >= 4) memcpy(&some, s + x, 4);
            else some = s[x];
            if (some & bits) return 1;
            x += right - x >= 8 ? 8 : right - x >= 4 ? 4 : 1;
        }
    }
    return 0;
}

/* Open pixels of a row to the tile, which has room for all: without branches, since which are open is
   anybody's guess. */
static inline size_t rsm__tile_add(const rsm__grid *g, rsm__tile *t, size_t count, uint32_t left, uint32_t right,
                                   uint32_t y)
{
    const rsm_points *p = g->points;
    size_t first = (size_t)y * g->width + left, ps = rsm__stride(p->position_stride, 12),
           ns = rsm__stride(p->normal_stride, 12);
    const float *position = rsm__at(p->positions, ps, first), *normal = rsm__at(p->normals, ns, first);
    const uint8_t *state = g->state + first;
    uint32_t x;
    for (x = left; x < right; x++) {
        t->px[count] = position[0];
        t->py[count] = position[1];
        t->pz[count] = position[2];
        t->nx[count] = normal[0];
        t->ny[count] = normal[1];
        t->nz[count] = normal[2];
        t->x[count] = x;
        t->y[count] = y;
        count += *state++ == RSM__OPEN;
        position = rsm__at(position, ps, 1);
        normal = rsm__at(normal, ns, 1);
    }
    return count;
}

static inline void rsm__interpolate_cell(rsm__grid *g, rsm__tile *tile, uint32_t left, uint32_t top, uint32_t right,
                                         uint32_t bottom)
{
    rsm__cell cell;
    uint32_t y;
    size_t count = 0;
    rsm__grid_lines(left, g->step, g->width, cell.column);
    rsm__grid_lines(top, g->step, g->height, cell.row);
    if (!rsm__cell_load(g, &cell)) return;
    for (y = top; y < bottom; y++) {
        if (count + (right - left) > RSM__TILE) {
            rsm__tile_interpolate(g, &cell, tile, count);
            count = 0;
        }
        count = rsm__tile_add(g, tile, count, left, right, y);
    }
    rsm__tile_interpolate(g, &cell, tile, count);
}

/* A row of cells. Corners are looked at only where a cell has open pixels: others may belong to another thread. */
static inline void rsm__interpolate_cells(void *context, size_t number)
{
    rsm__grid *g = (rsm__grid *)context;
    uint32_t x, top = (uint32_t)number * g->step, bottom = g->height - top < g->step ? g->height : top + g->step;
    rsm__tile tile;
    for (x = 0; x < g->width; x += g->step) {
        uint32_t right = g->width - x < g->step ? g->width : x + g->step;
        if (rsm__cell_open(g, x, top, right, bottom)) rsm__interpolate_cell(g, &tile, x, top, right, bottom);
        if (right == g->width) break;
    }
}

/* Corners that a cell with open pixels needs: wanted, unless they were evaluated before. A coarse grid wants pixels
   that are interpolated already too: what was evaluated replaces them. */
static inline void rsm__want_corners(rsm__grid *g, uint32_t x, uint32_t y)
{
    uint32_t column[2], row[2], k;
    rsm__grid_lines(x, g->step, g->width, column);
    rsm__grid_lines(y, g->step, g->height, row);
    for (k = 0; k < 4; k++) {
        uint8_t *s = g->state + (size_t)row[k >> 1] * g->width + column[k & 1];
        if (*s == RSM__OPEN) *s = RSM__WANTED;
        else if (*s == RSM__INTERPOLATED) *s = RSM__REPLACED;
    }
}

static inline uint32_t rsm__next_line(const rsm__grid *g, uint32_t at, uint32_t size)
{
    return at + g->step < size ? at + g->step : at + 1 < size ? size - 1 : size;
}

/* Wanted pixels, in order, to the list and to evaluated; without a grid all open ones. */
static inline size_t rsm__list_wanted(rsm__grid *g)
{
    uint32_t x, y;
    size_t found = 0;
    for (y = 0; y < g->height && g->step > 1; y += g->step)
        for (x = 0; x < g->width; x += g->step) {
            uint32_t right = g->width - x < g->step ? g->width : x + g->step,
                     bottom = g->height - y < g->step ? g->height : y + g->step;
            if (rsm__cell_open(g, x, y, right, bottom)) rsm__want_corners(g, x, y);
        }
    for (y = 0; y < g->height; y = rsm__next_line(g, y, g->height))
        for (x = 0; x < g->width; x = rsm__next_line(g, x, g->width)) {
            size_t at = (size_t)y * g->width + x;
            uint8_t state = g->state[at];
            if (g->step > 1 ? state != RSM__WANTED && state != RSM__REPLACED : state != RSM__OPEN) continue;
            g->state[at] = RSM__EVALUATED;
            g->list[found++] = (uint32_t)at;
        }
    return found;
}

static inline rsm_result rsm__interpolation_check(const rsm_interpolation *d, rsm_interpolation *out)
{
    memset(out, 0, sizeof *out);
    if (d) *out = *d;
    if (out->step == 0) out->step = 8;
    if (out->step < 2 || out->step > 64 || (out->step & (out->step - 1))) return RSM_ERR_DESC;
    if (out->levels > 6) return RSM_ERR_DESC;
    if (!(fabsf(out->normal_cosine) <= 1.0f) || !(out->plane_slope >= 0.0f && out->plane_slope <= 1e6f))
        return RSM_ERR_DESC;
    if (!(out->distance >= 0.0f && out->distance <= 1e9f) || !(fabsf(out->contrast) <= 1e6f)) return RSM_ERR_DESC;
    if (!(fabsf(out->reach) <= 1e6f)) return RSM_ERR_DESC;
    if (out->levels == 0) out->levels = 6;
    if (!(fabsf(out->normal_cosine) > 0.0f)) out->normal_cosine = 0.95f;
    if (!(out->plane_slope > 0.0f)) out->plane_slope = 0.05f;
    if (!(fabsf(out->contrast) > 0.0f)) out->contrast = 0.25f;
    if (!(fabsf(out->reach) > 0.0f)) out->reach = 0.25f;
    return RSM_OK;
}

/* One level: the grid of g->step (1: every pixel left), then the pixels that it does for. begin..end: its share. */
static inline rsm_result rsm__grid_level(rsm__grid *g, rsm__gather *gather, rsm_gather_stats *total, float begin,
                                         float end)
{
    rsm_points points = *g->points;
    rsm_gather_stats stats;
    rsm_result result;
    points.indices = g->list;
    points.index_count = rsm__list_wanted(g);
    points.occlusion = NULL;                     /* applied at full resolution, after interpolation */
    if (points.index_count == 0) return RSM_OK;
    gather->points = &points;
    gather->reach2 = g->step > 1 && g->desc->reach > 0.0f ? g->reach2 : NULL;
    gather->kernel = rsm__choose_kernel(g->lossy, gather->reach2 != NULL);
    result = rsm__gather_points(gather, &stats, begin, end);
    gather->points = g->points;
    if (result != RSM_OK) return result;
    total->evaluated += stats.evaluated;
    total->pairs += stats.pairs;
    total->clamped_share += stats.clamped_share * (double)stats.evaluated;
    total->outside_share += stats.outside_share * (double)stats.evaluated;
    if (g->step > 1) rsm__run(&gather->desc.system, (g->height + g->step - 1) / g->step, rsm__interpolate_cells, g);
    return RSM_OK;
}

/* The mask, and the factor of occlusion, which is for full resolution. Returns the number of bad points. */
static inline uint64_t rsm__grid_finish(rsm__grid *g, uint8_t *mask)
{
    const rsm_points *p = g->points;
    uint64_t bad = 0;
    size_t at, pixels = (size_t)g->width * g->height;
    int c;
    for (at = 0; at < pixels; at++) bad += g->state[at] == RSM__BAD;
    for (at = 0; at < pixels && mask; at++) mask[at] = g->state[at] / RSM__INTERPOLATED;
    for (at = 0; at < pixels && p->occlusion; at++) {
        float f;
        if (g->state[at] < RSM__INTERPOLATED) continue;
        f = *rsm__at(p->occlusion, rsm__stride(p->occlusion_stride, 4), at);
        f = f > 0.0f ? f < 1.0f ? f : 1.0f : 0.0f;
        for (c = 0; c < 3; c++) g->out[3 * at + (size_t)c] *= f;
    }
    return bad;
}

static inline void rsm__grid_start_row(void *context, size_t y)
{
    rsm__grid *g = (rsm__grid *)context;
    size_t at;
    for (at = y * g->width; at < (y + 1) * g->width; at++) {
        rsm__v3 x, n;
        uint64_t bad = 0;
        int lit = rsm__receiver(g->points, at, &x, &n, &bad);
        g->state[at] = lit ? RSM__OPEN : bad ? RSM__BAD : RSM__NONE;
        if (!lit) memset(g->out + 3 * at, 0, 3 * sizeof *g->out);
    }
}

static inline rsm_result rsm__interpolate_all(rsm__grid *g, rsm__gather *gather, uint32_t levels,
                                              rsm_gather_stats *total)
{
    uint32_t level, steps = 0;
    rsm_result result = RSM_OK;
    while (steps < levels && g->step >> steps > 1u) steps++;
    rsm__run(&gather->desc.system, g->height, rsm__grid_start_row, g);
    for (level = 0; level <= steps && result == RSM_OK; level++, g->step /= 2) {
        float begin = (float)level / (float)(steps + 1u), end = (float)(level + 1u) / (float)(steps + 1u);
        if (level == steps) g->step = 1;
        result = rsm__grid_level(g, gather, total, begin, end);
    }
    return result;
}

RSM_DEF rsm_result rsm_interpolate(const rsm_map *const *maps, size_t map_count, const rsm_gather_desc *desc,
                                   const rsm_interpolation *interpolation, const rsm_points *points, float *irradiance,
                                   rsm_gather_stats *stats)
{
    rsm__gather gather;
    rsm__grid g;
    rsm_interpolation d;
    rsm_gather_stats total;
    rsm__allocator a;
    rsm_result result = rsm__maps_check(maps, map_count);
    if (result != RSM_OK) return result;
    memset(&gather, 0, sizeof gather);
    memset(&total, 0, sizeof total);
    if (!desc || !rsm__points_valid(points) || points->indices || (!irradiance && points->count))
        return RSM_ERR_ARGUMENT;
    if (points->width == 0 || points->count % points->width != 0 || points->count > 0xffffffffu)
        return RSM_ERR_ARGUMENT;
    result = rsm__gather_check(desc, points, &gather.desc);
    if (result == RSM_OK) result = rsm__interpolation_check(interpolation, &d);
    if (result != RSM_OK) return result;
    if (desc->noise || gather.desc.interleave != 1 || desc->add) return RSM_ERR_DESC;
    a = rsm__allocator_of(&desc->system);
    g.points = points;
    g.desc = &d;
    g.out = gather.out = irradiance;
    g.width = points->width;
    g.height = (uint32_t)(points->count / points->width);
    g.step = d.step;
    g.suit = rsm__choose_suit();
    g.limits[0] = d.normal_cosine;
    g.limits[1] = d.plane_slope * d.plane_slope;
    g.limits[2] = d.distance > 0.0f ? d.distance * d.distance : RSM_FAR;
    g.list = (uint32_t *)rsm__alloc_array(&a, points->count + 1, sizeof *g.list);
    g.state = (uint8_t *)rsm__alloc_array(&a, points->count + 1, 1);
    g.reach2 = (float *)rsm__alloc_array(&a, points->count + 1, sizeof *g.reach2);
    g.lossy = rsm__loss_wanted(&gather, stats);
    gather.points = points;
    result = g.list && g.state && g.reach2 ? rsm__gather_open(&gather, maps, map_count, NULL, 0, &a) : RSM_ERR_ALLOC;
    if (result == RSM_OK) result = rsm__make_tallies(&gather, &a);     /* none is left to fail once levels write */
    if (result == RSM_OK) result = rsm__interpolate_all(&g, &gather, d.levels, &total);
    rsm__gather_close(&gather, &a);
    if (result == RSM_OK) {
        total.bad_points = rsm__grid_finish(&g, d.mask);
        if (total.evaluated) {
            total.clamped_share /= (double)total.evaluated;
            total.outside_share /= (double)total.evaluated;
        }
        if (stats) *stats = total;
    }
    rsm__free(&a, g.reach2);
    rsm__free(&a, g.state);
    rsm__free(&a, g.list);
    return result;
}

/* ---- >>filter: over frames, then over neighbours ---- */

/* Rows of the picture are RSM__PLANES rows of floats each, so that neighbours are compared in vectors: position,
   normal, colour, frames. No receiver: normal and frames are 0, as they are in a margin right of each row, which is as
   wide as the longest step and stands for the left margin of the row after: no tap has to ask where the picture
   ends. */
enum { RSM__RGB = 6, RSM__FRAMES = 9, RSM__PLANES = 10, RSM__MARGIN = 32, RSM__TASK_ROWS = 8 };

struct rsm_filter {
    rsm_system system;
    float     *memory[2];
    float     *history;            /* in one of them, of the last frame */
    float     *next;               /* in the other */
    size_t     spacing;            /* of rows of floats: a little more than widths that caches do not like */
    uint32_t   width, height;
    int        has_matrix;
    float      matrix[16];         /* of the frame in history */
};

struct rsm__filter_run;
typedef void (*rsm__filter_row)(const struct rsm__filter_run *r, size_t y);

typedef struct rsm__filter_run {
    rsm_filter            *filter;
    const rsm_filter_desc *desc;
    const rsm_points      *points;
    const float           *in;     /* irradiance; then rows of three rows, in_row floats apart */
    float                 *out;    /* the same, or with packed three floats a pixel */
    size_t                 in_row, out_row;
    int                    packed, recalls;
    uint32_t               step, history;
    float                  limits[3];      /* cosine, 1 / (1 - cosine), slope^2 */
    rsm__filter_row        accumulate, smooth, row;        /* row: one of them, which tasks are for */
} rsm__filter_run;

/* Weight of neighbour (or history) q, normal m for p, n: 0 across edges of normals and off the plane, falling smoothly
   to them. Arrays have the spacing s, and t. */
#define RSM__ALIKE(weight, p, n, s, q, m, t, limits)                                                         \
    do {                                                                                                     \
        float dx = (q)[0] - (p)[0], dy = (q)[t] - (p)[s], dz = (q)[2 * (t)] - (p)[2 * (s)];                  \
        float d2 = dx * dx + dy * dy + dz * dz, off = (n)[0] * dx + (n)[s] * dy + (n)[2 * (s)] * dz;         \
        float a = (n)[0] * (m)[0] + (n)[s] * (m)[t] + (n)[2 * (s)] * (m)[2 * (t)];                           \
        float b = 1.0f - off * off / ((limits)[2] * d2 + 1e-12f);                                            \
        a = (a - (limits)[0]) * (limits)[1];                                                                 \
        a = a > 0.0f ? a : 0.0f;                                                                             \
        a = a < 1.0f ? a : 1.0f;                                                                             \
        (weight) = a * (b > 0.0f ? b : 0.0f);                                                                \
    } while (0)

/* a where yes is 1, b where it is 0, both computed: compilers make branches of several choices by one condition, and
   then no vectors. */
RSM__INLINE float rsm__select(int yes, float a, float b)
{
    uint32_t mask = 0u - (uint32_t)yes, x, y;
    memcpy(&x, &a, sizeof x);
    memcpy(&y, &b, sizeof y);
    x = (x & mask) | (y & ~mask);
    memcpy(&a, &x, sizeof a);
    return a;
}

/* Planes of a row that comes soon: more of them are read side by side than processors foresee. */
RSM__INLINE void rsm__fetch_ahead(const float *p, size_t spacing, size_t planes)
{
    size_t c;
    for (c = 0; c < planes; c++) RSM__PREFETCH(p + c * spacing);
}

/* What this frame sees of a chunk of pixels, and what the last one knew of them. */
typedef struct rsm__chunk {
    float   now[RSM__PLANES][RSM__SPAN];
    float   given[9][RSM__SPAN + 1];      /* places, normals, light; also the place of the pixel after: after the last
                                              one of a row that of the pixel before */
    float   size2[RSM__SPAN];             /* square of the distance within which the last frame may show them */
    float   x[RSM__SPAN], y[RSM__SPAN];  /* where they were */
    float   u[RSM__SPAN], v[RSM__SPAN];  /* that is, how far between pixels i, j and i + 1, j + 1 of the last frame */
    int32_t i[RSM__SPAN], j[RSM__SPAN], there[RSM__SPAN];       /* there: 1 for a receiver; then, one that was seen */
    float   sums[5][RSM__SPAN];           /* of the last frame: colour, frames, weights */
} rsm__chunk;

/* Pixels of strides in floats. */
RSM__INLINE void rsm__chunk_read(rsm__chunk *k, const float *p, size_t ps, const float *n, size_t ns,
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

RSM__INLINE void rsm__chunk_set(rsm__chunk *k)
{
    size_t l, c;
    for (l = 0; l < RSM__SPAN; l++) {
        float x = k->given[0][l], y = k->given[1][l], z = k->given[2][l];
        float nx = k->given[3][l], ny = k->given[4][l], nz = k->given[5][l];
        int usable = (fabsf(x) <= 1e9f) & (fabsf(y) <= 1e9f) & (fabsf(z) <= 1e9f);      /* false for NaN */
        int faces = (fabsf(nx) <= 1e9f) & (fabsf(ny) <= 1e9f) & (fabsf(nz) <= 1e9f);
        k->there[l] = usable & faces & ((fabsf(nx) > 0.0f) | (fabsf(ny) > 0.0f) | (fabsf(nz) > 0.0f));
    }
    for (c = 0; c < RSM__RGB; c++)
        for (l = 0; l < RSM__SPAN; l++) k->now[c][l] = rsm__select(k->there[l], k->given[c][l], 0.0f);
    for (c = RSM__RGB; c < RSM__FRAMES; c++)
        for (l = 0; l < RSM__SPAN; l++)
            k->now[c][l] = rsm__select(k->there[l] & (fabsf(k->given[c][l]) <= RSM__MAX_FLOAT), k->given[c][l], 0.0f);
    for (l = 0; l < RSM__SPAN; l++) {
        float dx = k->given[0][l + 1] - k->given[0][l], dy = k->given[1][l + 1] - k->given[1][l],
              dz = k->given[2][l + 1] - k->given[2][l], d2 = dx * dx + dy * dy + dz * dz;
        k->size2[l] = d2 < 1e18f ? 16.0f * d2 + 1e-12f : 1e-12f;
        k->now[RSM__FRAMES][l] = (float)k->there[l];
    }
}

/* Pixels x .. x + end - 1 of row y. Four of this frame's pixels are how far the last one's may be. */
RSM__INLINE void rsm__chunk_load(const rsm__filter_run *r, rsm__chunk *k, size_t x, size_t y, size_t end)
{
    size_t ps = rsm__stride(r->points->position_stride, 12) / 4, ns = rsm__stride(r->points->normal_stride, 12) / 4;
    size_t at = y * r->filter->width + x, c;
    const float *p = r->points->positions + ps * at, *n = r->points->normals + ns * at, *light = r->in + 3 * at;
    if (end == RSM__SPAN && ps == 3 && ns == 3) rsm__chunk_read(k, p, 3, n, 3, light, RSM__SPAN);
    else {
        memset(k->given, 0, sizeof k->given);
        rsm__chunk_read(k, p, ps, n, ns, light, end);
    }
    for (c = 0; c < 3; c++)
        if (x + end < r->filter->width) k->given[c][end] = p[ps * end + c];
        else k->given[c][end] = end > 1 ? k->given[c][end - 2] : x > 0 ? *(p + c - ps) : p[c];
    rsm__chunk_set(k);
}

/* By the matrix of the last frame. */
RSM__INLINE void rsm__chunk_project(const rsm__filter_run *r, rsm__chunk *k)
{
    const float *m = r->filter->matrix, width = (float)r->filter->width, height = (float)r->filter->height,
                up = r->desc->top_first ? -0.5f : 0.5f;
    size_t l;
    for (l = 0; l < RSM__SPAN; l++) {
        float x = k->now[0][l], y = k->now[1][l], z = k->now[2][l], w = m[3] * x + m[7] * y + m[11] * z + m[15];
        float px = (m[0] * x + m[4] * y + m[8] * z + m[12]) / w, py = (m[1] * x + m[5] * y + m[9] * z + m[13]) / w;
        k->x[l] = (0.5f + 0.5f * px) * width;
        k->y[l] = (0.5f + up * py) * height;
        k->there[l] &= w > 0.0f;
    }
}

/* Between which pixels a place is. Within 1/64 of a pixel's centre it is the centre: a camera that stands still then
   finds one pixel, not four with weights of rounding, and does not blur. */
RSM__INLINE void rsm__chunk_place(const rsm__filter_run *r, rsm__chunk *k)
{
    const float width = (float)r->filter->width + 1.0f, height = (float)r->filter->height + 1.0f;
    size_t l;
    for (l = 0; l < RSM__SPAN; l++)
        k->there[l] &= (k->x[l] > -1.0f) & (k->y[l] > -1.0f) & (k->x[l] < width) & (k->y[l] < height);
    for (l = 0; l < RSM__SPAN; l++) {
        float x = rsm__select(k->there[l], k->x[l] + 7.5f, 8.0f), y = rsm__select(k->there[l], k->y[l] + 7.5f, 8.0f);
        float centre_x = (float)(int32_t)(x + 0.5f), centre_y = (float)(int32_t)(y + 0.5f);
        x = rsm__select(fabsf(x - centre_x) < 1.0f / 64.0f, centre_x, x);
        y = rsm__select(fabsf(y - centre_y) < 1.0f / 64.0f, centre_y, y);
        k->i[l] = (int32_t)x - 8;                /* above 0, so that conversion rounds down */
        k->j[l] = (int32_t)y - 8;
        k->u[l] = x - (float)(int32_t)x;
        k->v[l] = y - (float)(int32_t)y;
    }
}

/* Adds a pixel of the last frame for each of the chunk's from o on, planes t floats apart, where it shows the same
   surface. */
RSM__INLINE void rsm__chunk_recall(const rsm__filter_run *r, rsm__chunk *k, size_t o, const float *q, size_t t,
                                   const float *weights, size_t lanes)
{
    const float *limits = r->limits, *p = &k->now[0][o];
    size_t l;
    int motion = r->desc->motion != NULL;
    for (l = 0; l < lanes; l++) {
        float ex = q[l] - p[l], ey = q[t + l] - p[RSM__SPAN + l], ez = q[2 * t + l] - p[2 * RSM__SPAN + l];
        int nearby = (q[9 * t + l] > 0.0f) & (ex * ex + ey * ey + ez * ez <= k->size2[o + l]);
        float weight, same;
        RSM__ALIKE(weight, p + l, p + 3 * RSM__SPAN + l, RSM__SPAN, q + l, q + 3 * t + l, t, limits);
        same = p[3 * RSM__SPAN + l] * q[3 * t + l] + p[4 * RSM__SPAN + l] * q[4 * t + l] +
               p[5 * RSM__SPAN + l] * q[5 * t + l];
        same = same > 0.5f ? 1.0f : 0.0f;
        weight = (motion ? same : weight) * weights[l];
        weight = nearby ? weight : 0.0f;
        k->sums[0][o + l] += weight * q[6 * t + l];
        k->sums[1][o + l] += weight * q[7 * t + l];
        k->sums[2][o + l] += weight * q[8 * t + l];
        k->sums[3][o + l] += weight * q[9 * t + l];
        k->sums[4][o + l] += weight;
    }
}

/* The columns, less their own number, and rows that the pixels from o on were at. -1: none was seen; 1: they were a
   run, but for one column or row between; 0: they were not. */
RSM__INLINE int rsm__chunk_range(const rsm__chunk *k, size_t o, size_t lanes, int32_t low[2], int32_t high[2])
{
    int32_t a = 1 << 24, b = -a, c = a, d = -a;
    size_t l;
    for (l = o; l < o + lanes; l++) {
        int32_t off = (1 - k->there[l]) << 25, i = k->i[l] - (int32_t)l, j = k->j[l];
        a = i + off < a ? i + off : a;
        b = i - off > b ? i - off : b;
        c = j + off < c ? j + off : c;
        d = j - off > d ? j - off : d;
    }
    low[0] = a;
    low[1] = c;
    high[0] = b;
    high[1] = d;
    return a > b ? -1 : b - a <= 1 && d - c <= 1;
}

/* Runs of pixels, at most 3 x 3: from low to one after high. */
RSM__INLINE void rsm__past_runs(const rsm__filter_run *r, rsm__chunk *k, size_t o, const int32_t low[2],
                                const int32_t high[2], size_t lanes)
{
    const rsm_filter *f = r->filter;
    float weights[RSM__WIDE];
    int32_t i, j;
    size_t l;
    for (j = low[1]; j <= high[1] + 1; j++)
        for (i = low[0]; i <= high[0] + 1; i++) {
            int32_t any = 0;
            for (l = 0; l < lanes; l++) {
                int32_t dx = i + (int32_t)(o + l) - k->i[o + l], dy = j - k->j[o + l];
                float u = k->u[o + l], v = k->v[o + l];
                int one = k->there[o + l] & (dx >= 0) & (dx <= 1) & (dy >= 0) & (dy <= 1);
                float w = rsm__select(dx == 0, 1.0f - u, u) * rsm__select(dy == 0, 1.0f - v, v);
                weights[l] = rsm__select(one, w, 0.0f);
                any |= weights[l] > 0.0f;
            }
            if (any && j >= 0 && j < (int32_t)f->height) {
                const float *row = f->history + (size_t)j * RSM__PLANES * f->spacing;
                rsm__chunk_recall(r, k, o, row + (i + (int32_t)o), f->spacing, weights, lanes);
            }
        }
}

RSM__INLINE void rsm__past_each(const rsm__filter_run *r, rsm__chunk *k, size_t o, size_t lanes)
{
    const rsm_filter *f = r->filter;
    float room[RSM__PLANES][RSM__WIDE], weights[RSM__WIDE];
    size_t l, c;
    int32_t n;
    for (n = 0; n < 4; n++) {
        for (l = 0; l < lanes; l++) {
            int32_t x = k->i[o + l] + (n & 1), y = k->j[o + l] + (n >> 1);
            int inside = k->there[o + l] && x >= 0 && y >= 0 && x < (int32_t)f->width && y < (int32_t)f->height;
            const float *q = inside ? f->history + (size_t)y * RSM__PLANES * f->spacing + (size_t)x : NULL;
            weights[l] = (n & 1 ? k->u[o + l] : 1.0f - k->u[o + l]) * (n & 2 ? k->v[o + l] : 1.0f - k->v[o + l]);
            for (c = 0; c < RSM__PLANES; c++) room[c][l] = q ? q[c * f->spacing] : 0.0f;
        }
        rsm__chunk_recall(r, k, o, room[0], RSM__WIDE, weights, lanes);
    }
}

/* Bilinear over the four pixels of the last frame about each place. Where neighbours were neighbours but for one column
   or row, as in most chunks, runs of pixels do; else each is fetched alone. */
RSM__INLINE void rsm__chunk_past(const rsm__filter_run *r, rsm__chunk *k, size_t lanes)
{
    int32_t low[2], high[2];
    size_t o;
    int whole = rsm__chunk_range(k, 0, RSM__SPAN, low, high), run = whole;
    memset(k->sums, 0, sizeof k->sums);
    for (o = 0; o < RSM__SPAN && whole >= 0; o += lanes) {
        if (!whole) run = rsm__chunk_range(k, o, lanes, low, high);
        if (run > 0) rsm__past_runs(r, k, o, low, high, lanes);
        else if (run == 0) rsm__past_each(r, k, o, lanes);
    }
}

/* Puts what the last frames knew into what this one sees. */
RSM__INLINE void rsm__chunk_blend(rsm__chunk *k, float history)
{
    float frames[RSM__SPAN], most[RSM__SPAN];
    size_t l, c;
    for (l = 0; l < RSM__SPAN; l++) {
        float sum = k->sums[4][l] > 0.01f ? k->sums[4][l] : 0.01f, more = k->sums[3][l] / sum + 1.0f;
        k->there[l] = (k->sums[4][l] > 0.01f) & (k->sums[3][l] > 0.0f);
        most[l] = sum;
        frames[l] = more < history ? more : history;
    }
    for (c = 0; c < 3; c++)
        for (l = 0; l < RSM__SPAN; l++) {
            float now = k->now[RSM__RGB + c][l], old = k->sums[c][l] / most[l];
            k->now[RSM__RGB + c][l] = rsm__select(k->there[l], old + (now - old) / frames[l], now);
        }
    for (l = 0; l < RSM__SPAN; l++)
        k->now[RSM__FRAMES][l] = rsm__select(k->there[l], frames[l], k->now[RSM__FRAMES][l]);
}

RSM__INLINE void rsm__accumulate(const rsm__filter_run *r, size_t y, size_t lanes)
{
    const float *motion = r->desc->motion;
    size_t x, c, l, width = r->filter->width, s = r->filter->spacing;
    rsm__chunk k;
    for (x = 0; x < width; x += RSM__SPAN) {
        size_t end = width - x < RSM__SPAN ? width - x : (size_t)RSM__SPAN;
        float *to = r->filter->next + y * RSM__PLANES * s + x;
        rsm__chunk_load(r, &k, x, y, end);
        for (l = 0; motion && l < RSM__SPAN; l++) {             /* moved surfaces are found by motion only */
            k.x[l] = l < end ? motion[2 * (y * width + x + l)] : 0.0f;
            k.y[l] = l < end ? motion[2 * (y * width + x + l) + 1] : 0.0f;
            k.size2[l] = RSM_FAR;
        }
        if (r->recalls) {
            for (l = 0; y + 1 < r->filter->height && l < end; l += RSM__WIDE)     /* most cameras move little */
                rsm__fetch_ahead(r->filter->history + (y + 1) * RSM__PLANES * s + x + l, s, RSM__PLANES);
            if (!motion) rsm__chunk_project(r, &k);
            rsm__chunk_place(r, &k);
            rsm__chunk_past(r, &k, lanes);
            rsm__chunk_blend(&k, (float)r->history);
        }
        for (c = 0; c < RSM__PLANES; c++)
            if (end == RSM__SPAN) memcpy(to + c * s, k.now[c], sizeof k.now[c]);
            else memcpy(to + c * s, k.now[c], end * sizeof *to);                /* margins stay 0 */
    }
}

/* A pixel with few neighbours like it keeps the noise of its own samples: of its 25 of 400 one that is near counts 16
   times. It is then no brighter than its brightest neighbour. All weights are 4 of its own and 12. */
RSM__INLINE float rsm__despeckled(float x, float most, int few)
{
    return rsm__select(few & (most > 0.0f) & (x > most), most, x);
}

/* How far a neighbour's shape and colour are. */
typedef struct rsm__tap { ptrdiff_t shape, rgb; float weight; } rsm__tap;

static inline size_t rsm__taps(const rsm__filter_run *r, size_t y, rsm__tap taps[8])
{
    ptrdiff_t i, j, row = (ptrdiff_t)y, step = (ptrdiff_t)r->step;
    size_t count = 0;
    for (j = -step; j <= step; j += step)
        for (i = -step; i <= step; i += step) {
            if ((i == 0 && j == 0) || row + j < 0 || row + j >= (ptrdiff_t)r->filter->height) continue;
            taps[count].shape = j * (ptrdiff_t)(RSM__PLANES * r->filter->spacing) + i;
            taps[count].rgb = j * (ptrdiff_t)r->in_row + i;
            taps[count++].weight = i && j ? 1.0f : 2.0f;
        }
    return count;
}

/* One pass of the a-trous filter on one chunk. */
RSM__INLINE void rsm__smooth_chunk(const rsm__filter_run *r, const float *p, const float *rgb, const rsm__tap *taps,
                                   size_t count, float out[3][RSM__WIDE], size_t lanes)
{
    const float *n = p + 3 * r->filter->spacing, limits[3] = { r->limits[0], r->limits[1], r->limits[2] };
    float red[RSM__WIDE], green[RSM__WIDE], blue[RSM__WIDE], total[RSM__WIDE];
    float most_red[RSM__WIDE], most_green[RSM__WIDE], most_blue[RSM__WIDE];
    size_t k, l, s = r->filter->spacing;
    for (l = 0; l < lanes; l++) {
        red[l] = 4.0f * rgb[l];
        green[l] = 4.0f * rgb[s + l];
        blue[l] = 4.0f * rgb[2 * s + l];
        total[l] = 4.0f;
        most_red[l] = most_green[l] = most_blue[l] = 0.0f;
    }
    for (k = 0; k < count; k++) {
        const float *q = p + taps[k].shape, *m = q + 3 * s, *c = rgb + taps[k].rgb;
        const float share = taps[k].weight;
        for (l = 0; l < lanes; l++) {
            float weight, x = c[l], y = c[s + l], z = c[2 * s + l];
            RSM__ALIKE(weight, p + l, n + l, s, q + l, m + l, s, limits);
            weight *= share;
            red[l] += weight * x;
            green[l] += weight * y;
            blue[l] += weight * z;
            total[l] += weight;
            most_red[l] = x > most_red[l] ? x : most_red[l];
            most_green[l] = y > most_green[l] ? y : most_green[l];
            most_blue[l] = z > most_blue[l] ? z : most_blue[l];
        }
    }
    for (l = 0; l < lanes; l++) {
        int few = total[l] < 8.0f;
        out[0][l] = rsm__despeckled(red[l] / total[l], most_red[l], few);
        out[1][l] = rsm__despeckled(green[l] / total[l], most_green[l], few);
        out[2][l] = rsm__despeckled(blue[l] / total[l], most_blue[l], few);
    }
}

/* One pass: 3 x 3 taps, step apart. */
RSM__INLINE void rsm__smooth(const rsm__filter_run *r, size_t y, size_t lanes)
{
    const rsm_filter *f = r->filter;
    const float *p = f->next + y * RSM__PLANES * f->spacing, *rgb = r->in + y * r->in_row;
    float *to = r->out + y * r->out_row, out[3][RSM__WIDE], mixed[3 * RSM__WIDE];
    size_t x, l, c, width = f->width;
    rsm__tap taps[8];
    size_t count = rsm__taps(r, y, taps), below = y + r->step + 1 < f->height ? r->step + 1 : 0;
    size_t ahead = below * RSM__PLANES * f->spacing, rgb_ahead = below * r->in_row;
    for (x = 0; x < width; x += lanes) {
        size_t end = width - x < lanes ? width - x : lanes;
        rsm__fetch_ahead(p + x + ahead, f->spacing, RSM__RGB);
        rsm__fetch_ahead(rgb + x + rgb_ahead, f->spacing, 3);
        rsm__smooth_chunk(r, p + x, rgb + x, taps, count, out, lanes);
        for (c = 0; !r->packed && c < 3; c++)
            if (end == lanes) memcpy(to + c * f->spacing + x, out[c], lanes * sizeof *to);
            else memcpy(to + c * f->spacing + x, out[c], end * sizeof *to);     /* margins stay 0 */
        for (l = 0; r->packed && l < lanes; l++) {
            mixed[3 * l] = out[0][l];
            mixed[3 * l + 1] = out[1][l];
            mixed[3 * l + 2] = out[2][l];
        }
        if (r->packed) memcpy(to + 3 * x, mixed, 3 * end * sizeof *to);
    }
}

#define RSM__FILTERS(name, target, lanes)                                                                    \
    target RSM__HOT static void name##_accumulate(const rsm__filter_run *r, size_t y)                        \
    {                                                                                                        \
        rsm__accumulate(r, y, lanes);                                                                        \
    }                                                                                                        \
    target RSM__HOT static void name##_smooth(const rsm__filter_run *r, size_t y) { rsm__smooth(r, y, lanes); }

RSM__FILTERS(rsm__filter_plain, RSM__ANY_TARGET, 8)
#if RSM__X86
RSM__FILTERS(rsm__filter_avx2, RSM__TARGET_AVX2, 8)
RSM__FILTERS(rsm__filter_avx512, RSM__TARGET_AVX512, 16)
#endif

static inline void rsm__choose_filter(rsm__filter_run *r)
{
    r->accumulate = rsm__filter_plain_accumulate;
    r->smooth = rsm__filter_plain_smooth;
#if RSM__X86
    if (!rsm__cpu_has_avx2()) return;
    r->accumulate = rsm__filter_avx2_accumulate;
    r->smooth = rsm__filter_avx2_smooth;
    if (!rsm__cpu_has_avx512()) return;
    r->accumulate = rsm__filter_avx512_accumulate;
    r->smooth = rsm__filter_avx512_smooth;
#endif
}

RSM_DEF rsm_result rsm_filter_create(uint32_t width, uint32_t height, const rsm_system *system, rsm_filter **out)
{
    rsm_system none;
    rsm__allocator a;
    rsm_filter *f;
    size_t floats, spacing = (size_t)width + RSM__MARGIN;
    spacing += spacing % 64u ? 0u : 16u;
    memset(&none, 0, sizeof none);
    if (!system) system = &none;
    if (!out || width == 0 || height == 0 || !rsm__system_valid(system)) return RSM_ERR_ARGUMENT;
    if (width > 65536u || height > 65536u || !rsm__mul_size(spacing * RSM__PLANES, height, &floats) ||
        !rsm__add_size(floats, 2 * RSM__MARGIN, &floats))        /* before the first row; for lanes after the last */
        return RSM_ERR_LIMIT;
    a = rsm__allocator_of(system);
    f = (rsm_filter *)rsm__alloc(&a, sizeof *f);
    if (!f) return RSM_ERR_ALLOC;
    memset(f, 0, sizeof *f);
    f->system = *system;
    f->width = width;
    f->height = height;
    f->spacing = spacing;
    f->memory[0] = (float *)rsm__alloc_array(&a, floats, sizeof(float));
    f->memory[1] = (float *)rsm__alloc_array(&a, floats, sizeof(float));
    if (!f->memory[0] || !f->memory[1]) {
        rsm_filter_free(f);
        return RSM_ERR_ALLOC;
    }
    memset(f->memory[0], 0, floats * sizeof(float));
    memset(f->memory[1], 0, floats * sizeof(float));
    f->history = f->memory[0] + RSM__MARGIN;
    f->next = f->memory[1] + RSM__MARGIN;
    *out = f;
    return RSM_OK;
}

RSM_DEF void rsm_filter_free(rsm_filter *filter)
{
    rsm__allocator a;
    if (!filter) return;
    a = rsm__allocator_of(&filter->system);
    rsm__free(&a, filter->memory[1]);
    rsm__free(&a, filter->memory[0]);
    rsm__free(&a, filter);
}

RSM_DEF void rsm_filter_reset(rsm_filter *filter)
{
    size_t y;
    if (!filter) return;
    for (y = 0; y < filter->height; y++)
        memset(filter->history + (y * RSM__PLANES + RSM__FRAMES) * filter->spacing, 0,
               filter->width * sizeof *filter->history);
    filter->has_matrix = 0;
}

static inline void rsm__pack(const rsm__filter_run *r, size_t y)
{
    size_t x, c, width = r->filter->width;
    for (x = 0; x < width; x++)
        for (c = 0; c < 3; c++) r->out[3 * (y * width + x) + c] = r->in[y * r->in_row + c * r->filter->spacing + x];
}

/* Rows of a task, so that taps above were fetched by the same thread. */
static inline void rsm__filter_band(void *context, size_t band)
{
    const rsm__filter_run *r = (const rsm__filter_run *)context;
    size_t y, end = (band + 1) * RSM__TASK_ROWS;
    for (y = band * RSM__TASK_ROWS; y < end && y < r->filter->height; y++) r->row(r, y);
}

static inline void rsm__filter_rows(rsm__filter_run *r, rsm__filter_row row)
{
    r->row = row;
    rsm__run(&r->filter->system, (r->filter->height + RSM__TASK_ROWS - 1) / RSM__TASK_ROWS, rsm__filter_band, r);
}

/* From next to out. What lies between goes where the last frame was, which nothing asks for any more: to its positions
   and its normals in turn. */
static inline void rsm__filter_passes(rsm__filter_run *r, float *out)
{
    rsm_filter *f = r->filter;
    uint32_t pass;
    r->in = f->next + RSM__RGB * f->spacing;
    r->in_row = RSM__PLANES * f->spacing;
    r->out = out;
    if (r->desc->passes == 0) rsm__filter_rows(r, rsm__pack);
    for (pass = 0; pass < r->desc->passes; pass++) {
        r->packed = pass + 1 == r->desc->passes;
        r->out = r->packed ? out : f->history + (pass % 2 ? 3 * f->spacing : 0);
        r->out_row = r->packed ? 3 * (size_t)f->width : RSM__PLANES * f->spacing;
        r->step = 1u << pass;
        rsm__filter_rows(r, r->smooth);
        r->in = r->out;
    }
}

/* Of a run that has a filter, what to filter and kernels. */
static inline void rsm__filter_frame(rsm__filter_run *r, float *out)
{
    rsm_filter *f = r->filter;
    const rsm_filter_desc *d = r->desc;
    float *swap;
    r->history = d->history ? d->history : 8;
    r->recalls = r->history > 1 && (d->motion || (d->view_projection && f->has_matrix));
    r->limits[0] = d->normal_cosine > 0.0f ? d->normal_cosine : 0.9f;
    r->limits[1] = 1.0f / (1.0f - r->limits[0]);
    r->limits[2] = d->plane_slope > 0.0f ? d->plane_slope * d->plane_slope : 0.1f * 0.1f;
    rsm__filter_rows(r, r->accumulate);
    rsm__filter_passes(r, out);
    swap = f->history;
    f->history = f->next;
    f->next = swap;
    f->has_matrix = d->view_projection != NULL;
    if (d->view_projection) memcpy(f->matrix, d->view_projection, sizeof f->matrix);
}

RSM_DEF rsm_result rsm_filter_apply(rsm_filter *filter, const rsm_filter_desc *desc, const rsm_points *points,
                                    const float *irradiance, float *out)
{
    rsm__filter_run r;
    int i;
    if (!filter || !desc || !irradiance || !out || !rsm__points_valid(points) || points->indices)
        return RSM_ERR_ARGUMENT;
    if (points->count != (size_t)filter->width * filter->height) return RSM_ERR_ARGUMENT;
    if (desc->passes > 6 || desc->history > 1000 || !(desc->normal_cosine >= 0.0f && desc->normal_cosine < 1.0f))
        return RSM_ERR_DESC;
    if (!(desc->plane_slope >= 0.0f && desc->plane_slope <= 1e6f)) return RSM_ERR_DESC;
    for (i = 0; i < 16 && desc->view_projection; i++)
        if (!rsm__finite(desc->view_projection[i])) return RSM_ERR_DESC;
    memset(&r, 0, sizeof r);
    r.filter = filter;
    r.desc = desc;
    r.points = points;
    r.in = irradiance;
    rsm__choose_filter(&r);
    rsm__filter_frame(&r, out);
    return RSM_OK;
}

/* ---- >>direct light ---- */

typedef struct rsm__direct {
    const rsm_map    *map;
    rsm_direct_desc   desc;
    const rsm_points *points;
    float            *out;
} rsm__direct;

/* Irradiance facing the light at p without shadow, times the cosine; 0 outside a cone or behind a patch. */
static inline float rsm__unshadowed(const rsm_map *map, rsm__v3 p, rsm__v3 n, rsm__v3 to_light)
{
    rsm__v3 d = rsm__v3_sub(p, rsm__v3_load(map->desc.light.position)), q;
    float d2 = rsm__v3_dot(d, d), cosine = rsm__v3_dot(n, to_light), out = -rsm__v3_dot(map->axis, to_light);
    if (!(cosine > 0.0f)) return 0.0f;
    if (rsm__is_sun(map)) return cosine;
    if (!(d2 > 0.0f)) return 0.0f;
    switch (map->desc.light.kind) {
    case RSM_LIGHT_SPOT: if (!(out >= map->cos_half)) return 0.0f; break;
    case RSM_LIGHT_SQUARE_SPOT:
        q = rsm__to_face(map, 0, p);
        if (!(q.z > 0.0f && fabsf(q.x) <= 1.0f && fabsf(q.y) <= 1.0f)) return 0.0f;
        break;
    case RSM_LIGHT_PATCH: cosine *= out > 0.0f ? out : 0.0f; break;
    default: break;
    }
    return cosine / d2;
}

/* Lit share of taps x taps texels about p, weighted as a box moved by fractions of a texel; 2 taps: bilinear. */
static inline float rsm__pcf(const rsm_map *map, const rsm_direct_desc *desc, rsm__v3 p, float cosine)
{
    uint32_t face = rsm__face_of(map, p);
    rsm__v3 q = rsm__to_face(map, face, p);
    float side = (float)map->size, x, y, texel, bias, slope, sum = 0.0f, total = 0.0f,
          radius = 0.5f * (float)(desc->taps - 1);
    float fx, fy;
    uint32_t i, j;
    if (face >= map->faces) return 0.0f;
    if (!rsm__is_sun(map) && !(q.z > 0.0f)) return 0.0f;
    if (!(fabsf(q.x) <= 1.0f && fabsf(q.y) <= 1.0f)) return rsm__is_sun(map) ? 1.0f : 0.0f;
    texel = 2.0f / side * map->extent * (rsm__is_sun(map) ? 1.0f : q.z);
    slope = cosine < 1.0f ? sqrtf(1.0f - cosine * cosine) / (cosine > 0.1f ? cosine : 0.1f) : 0.0f;
    slope = slope < 10.0f ? slope : 10.0f;
    bias =
        texel * (desc->bias + desc->slope_bias * slope * 0.7072f * (float)desc->taps); /* the farthest tap's centre */
    x = (q.x * 0.5f + 0.5f) * side - radius;     /* the first tap's texel is floor(x) */
    y = (q.y * 0.5f + 0.5f) * side - radius;
    fx = x - floorf(x);
    fy = y - floorf(y);
    for (j = 0; j < desc->taps; j++)
        for (i = 0; i < desc->taps; i++) {
            int32_t s = (int32_t)floorf(x) + (int32_t)i, t = (int32_t)floorf(y) + (int32_t)j;
            float weight = (i == 0                ? 1.0f - fx
                            : i == desc->taps - 1 ? fx
                                                  : 1.0f) *
                           (j == 0                ? 1.0f - fy
                            : j == desc->taps - 1 ? fy
                                                  : 1.0f);
            if (desc->taps == 1) weight = 1.0f;
            total += weight;
            s = s < 0 ? 0 : s >= (int32_t)map->size ? (int32_t)map->size - 1 : s;
            t = t < 0 ? 0 : t >= (int32_t)map->size ? (int32_t)map->size - 1 : t;
            if (q.z - bias <= map->texels[((size_t)face * map->size + (size_t)t) * map->size + (size_t)s].depth)
                sum += weight;
        }
    return total > 0.0f ? sum / total : 0.0f;
}

static inline void rsm__direct_batch(void *context, size_t batch)
{
    const rsm__direct *w = (const rsm__direct *)context;
    const rsm_points *p = w->points;
    size_t count = p->indices ? p->index_count : p->count, i = batch * 256, end = i + 256 < count ? i + 256 : count;
    for (; i < end; i++) {
        size_t at = p->indices ? p->indices[i] : i;
        float light = 0.0f, *out = w->out + 3 * at;
        rsm__v3 x, n;
        uint64_t bad = 0;
        int c;
        if (rsm__receiver(p, at, &x, &n, &bad)) {
            rsm__v3 to_light = rsm__to_light(w->map, x);
            light = rsm__unshadowed(w->map, x, n, to_light);
            if (light > 0.0f) light *= rsm__pcf(w->map, &w->desc, x, rsm__v3_dot(n, to_light));
        }
        for (c = 0; c < 3; c++) out[c] = (w->desc.add ? out[c] : 0.0f) + light * w->map->desc.light.value[c];
    }
}

RSM_DEF rsm_direct_desc rsm_direct_default(void)
{
    rsm_direct_desc d;
    memset(&d, 0, sizeof d);
    d.taps = 2;
    d.bias = 0.5f;
    d.slope_bias = 1.0f;
    return d;
}

RSM_DEF rsm_result rsm_direct(const rsm_map *map, const rsm_direct_desc *desc, const rsm_points *points,
                              float *irradiance)
{
    rsm__direct w;
    size_t count;
    if (!map || !desc || !rsm__points_valid(points) || (!irradiance && points->count)) return RSM_ERR_ARGUMENT;
    if (!map->finished) return RSM_ERR_ORDER;
    if (desc->taps > 15 || !(desc->bias >= 0.0f && desc->bias <= 1e6f)) return RSM_ERR_DESC;
    if (!(desc->slope_bias >= 0.0f && desc->slope_bias <= 1e6f) || !rsm__system_valid(&desc->system))
        return RSM_ERR_DESC;
    w.map = map;
    w.desc = *desc;
    if (w.desc.taps == 0) w.desc.taps = 2;
    w.points = points;
    w.out = irradiance;
    count = points->indices ? points->index_count : points->count;
    if (!rsm__run_steps(&desc->system, (count + 255) / 256, rsm__direct_batch, &w, 0.0f, 1.0f))
        return RSM_ERR_CANCELLED;
    return RSM_OK;
}

/* ---- >>public: maps ---- */

RSM_DEF const char *rsm_result_text(rsm_result result)
{
    switch (result) {
#define RSM__TEXT(name, text) case name: return text;
    RSM_RESULTS(RSM__TEXT)
#undef RSM__TEXT
    case RSM_RESULT_COUNT: break;
    }
    return "unknown result";
}

static inline size_t rsm__align(size_t size) { return (size + 15u) & ~(size_t)15u; }

RSM_DEF size_t rsm_map_size(const rsm_desc *desc)
{
    rsm_map map;
    size_t rows, texels, bytes, sums;
    if (!desc || rsm__map_set(&map, desc) != RSM_OK) return 0;
    rows = (size_t)map.size * map.faces;
    if (!rsm__mul_size(rows, map.size, &texels) || !rsm__mul_size(texels, sizeof(rsm_texel), &bytes)) return 0;
    if (!rsm__mul_size(texels, sizeof(double), &sums) || !rsm__add_size(bytes, sums, &bytes)) return 0;
    if (!rsm__add_size(bytes, (rows + 1) * sizeof(double) + rsm__align(sizeof map) + 64, &bytes)) return 0;
    return bytes;
}

RSM_DEF rsm_result rsm_map_init(const rsm_desc *desc, void *memory, size_t size, rsm_map **out)
{
    rsm_map map, *to;
    char *at;
    size_t texels, i;
    rsm_result result;
    if (!desc || !memory || !out) return RSM_ERR_ARGUMENT;
    memset(&map, 0, sizeof map);
    result = rsm__map_set(&map, desc);
    if (result != RSM_OK) return result;
    if (rsm_map_size(desc) == 0) return RSM_ERR_LIMIT;
    if (size < rsm_map_size(desc) || (uintptr_t)memory % 8 != 0) return RSM_ERR_MEMORY;
    texels = rsm__texel_count(&map);
    map.room = map.faces;
    at = (char *)memory + rsm__align(sizeof map);
    map.texels = (rsm_texel *)(void *)at;
    at += rsm__align(texels * sizeof(rsm_texel));
    map.sums = (double *)(void *)at;
    map.rows = map.sums + texels;
    to = (rsm_map *)memory;
    *to = map;
    for (i = 0; i < texels; i++) rsm__texel_clear(map.texels + i);
    *out = to;
    return RSM_OK;
}

RSM_DEF rsm_result rsm_map_create(const rsm_desc *desc, rsm_map **out)
{
    rsm_map checked;
    rsm__allocator a;
    rsm_result result;
    size_t size;
    void *memory;
    if (!desc || !out) return RSM_ERR_ARGUMENT;
    result = rsm__map_set(&checked, desc);
    if (result != RSM_OK) return result;
    size = rsm_map_size(desc);
    if (size == 0) return RSM_ERR_LIMIT;
    a = rsm__allocator_of(&desc->system);
    memory = rsm__alloc(&a, size);
    if (!memory) return RSM_ERR_ALLOC;
    result = rsm_map_init(desc, memory, size, out);
    if (result != RSM_OK) rsm__free(&a, memory);
    else (*out)->owned = 1;
    return result;
}

RSM_DEF rsm_result rsm_map_restart(rsm_map *map, const rsm_light *light)
{
    rsm_map next;
    rsm_desc desc;
    rsm_result result;
    size_t i, texels;
    if (!map) return RSM_ERR_ARGUMENT;
    desc = map->desc;
    if (light) desc.light = *light;
    memset(&next, 0, sizeof next);
    result = rsm__map_set(&next, &desc);
    if (result != RSM_OK) return result;
    if (next.faces > map->room) return RSM_ERR_MEMORY;
    next.room = map->room;
    next.owned = map->owned;
    next.texels = map->texels;
    texels = rsm__texel_count(&next);
    next.sums = map->sums;
    next.rows = map->rows;
    *map = next;
    for (i = 0; i < texels; i++) rsm__texel_clear(map->texels + i);
    return RSM_OK;
}

RSM_DEF void rsm_map_free(rsm_map *map)
{
    rsm__allocator a;
    if (!map || !map->owned) return;
    a = rsm__allocator_of(&map->desc.system);
    rsm__free(&a, map);
}

RSM_DEF uint32_t rsm_map_faces(const rsm_map *map) { return map ? map->faces : 0; }
RSM_DEF uint32_t rsm_map_side(const rsm_map *map) { return map ? map->size : 0; }
RSM_DEF const rsm_texel *rsm_map_texels(const rsm_map *map) { return map ? map->texels : NULL; }

RSM_DEF rsm_result rsm_map_matrix(const rsm_map *map, uint32_t face, float world_to_clip[16])
{
    rsm__v3 r, u, a, p;
    float n, f, sx, sy, z[2], row[4][4];
    int i, k, perspective;
    if (!map || !world_to_clip || face >= map->faces) return RSM_ERR_ARGUMENT;
    rsm__face_frame(map, face, &r, &u, &a);
    p = rsm__v3_load(map->desc.light.position);
    n = map->desc.light.near_depth;
    f = map->desc.light.far_depth;
    perspective = !rsm__is_sun(map);
    sx = 1.0f / map->extent;
    sy = map->desc.clip_y_down ? -sx : sx;
    /* clip z = z[0] depth + z[1], over w = depth in perspective */
    z[0] = perspective ? f / (f - n) : 1.0f / (f - n);
    z[1] = perspective ? -n * f / (f - n) : -n / (f - n);
    if (!map->desc.clip_zero_to_one) {
        z[0] = 2.0f * z[0] - (perspective ? 1.0f : 0.0f);
        z[1] = 2.0f * z[1] - (perspective ? 0.0f : 1.0f);
    }
    for (i = 0; i < 3; i++) {
        float axis = i == 0 ? a.x : i == 1 ? a.y : a.z;
        row[0][i] = sx * (i == 0 ? r.x : i == 1 ? r.y : r.z);
        row[1][i] = sy * (i == 0 ? u.x : i == 1 ? u.y : u.z);
        row[2][i] = z[0] * axis;
        row[3][i] = perspective ? axis : 0.0f;
    }
    row[0][3] = -sx * rsm__v3_dot(r, p);
    row[1][3] = -sy * rsm__v3_dot(u, p);
    row[2][3] = z[1] - z[0] * rsm__v3_dot(a, p);
    row[3][3] = perspective ? -rsm__v3_dot(a, p) : 1.0f;
    for (i = 0; i < 4; i++)
        for (k = 0; k < 4; k++) world_to_clip[4 * k + i] = row[i][k];
    return RSM_OK;
}

RSM_DEF rsm_result rsm_map_project(const rsm_map *map, const float point[3], uint32_t *face, float uv[2], float *depth)
{
    rsm__v3 q;
    uint32_t f;
    if (!map || !point || !face || !uv || !depth || !rsm__usable(rsm__v3_load(point))) return RSM_ERR_ARGUMENT;
    f = rsm__face_of(map, rsm__v3_load(point));
    if (f >= map->faces) f = 0;                  /* behind a patch */
    q = rsm__to_face(map, f, rsm__v3_load(point));
    if (!rsm__is_sun(map) && !(q.z > 0.0f)) q.x = q.y = 0.0f;
    *face = f;
    uv[0] = q.x * 0.5f + 0.5f;
    uv[1] = q.y * 0.5f + 0.5f;
    *depth = q.z;
    return RSM_OK;
}

/* Depth along the face from what a depth buffer holds, 0..1. */
static inline float rsm__unproject_depth(const rsm_map *map, float stored)
{
    float n = map->desc.light.near_depth, f = map->desc.light.far_depth;
    if (rsm__is_sun(map)) return n + stored * (f - n);
    return n * f / (f - stored * (f - n));
}

static inline float rsm__from_srgb(uint8_t value)
{
    float s = (float)value * (1.0f / 255.0f);
    return s <= 0.04045f ? s * (1.0f / 12.92f) : rsm__pow((s + 0.055f) * (1.0f / 1.055f), 2.4f);
}

typedef struct rsm__filling { rsm_map *map; uint32_t face; const rsm_buffers *buffers; float srgb[256]; } rsm__filling;

static inline void rsm__fill_texel(const rsm__filling *f, uint32_t i, uint32_t j)
{
    rsm_map *map = f->map;
    const rsm_buffers *b = f->buffers;
    int turned = !map->desc.clip_top_first != !map->desc.clip_y_down;    /* row 0 is the top, v = 1; both: the foot */
    size_t at = (size_t)(turned ? map->size - 1u - j : j) * map->size + i;
    rsm__v3 normal = rsm__v3_load(rsm__at(b->normals, rsm__stride(b->normal_stride, 12), at)), position;
    float stored = b->depth ? *rsm__at(b->depth, rsm__stride(b->depth_stride, 4), at) : 0.0f, albedo[3] = { 1, 1, 1 };
    uint32_t material = 0;
    int c;
    rsm__texel_clear(map->texels + ((size_t)f->face * map->size + j) * map->size + i);
    if (normal.x == 0.0f && normal.y == 0.0f && normal.z == 0.0f) return;
    if (b->depth && stored >= 1.0f) return;
    if (b->positions) position = rsm__v3_load(rsm__at(b->positions, rsm__stride(b->position_stride, 12), at));
    else position = rsm__from_face(map, f->face, rsm__texel_centre(map, i), rsm__texel_centre(map, j),
                                   rsm__unproject_depth(map, stored));
    if (b->albedo) memcpy(albedo, rsm__at(b->albedo, rsm__stride(b->albedo_stride, 12), at), sizeof albedo);
    else if (b->albedo_srgb)
        for (c = 0; c < 3; c++) albedo[c] = f->srgb[b->albedo_srgb[at * rsm__stride(b->srgb_stride, 4) + (size_t)c]];
    if (b->materials)
        memcpy(&material, (const char *)(const void *)b->materials + at * rsm__stride(b->material_stride, 4),
               sizeof material);
    rsm__texel_set(map, f->face, i, j, position, normal, albedo, material);
}

static inline void rsm__fill_row(void *context, size_t row)
{
    const rsm__filling *f = (const rsm__filling *)context;
    uint32_t i;
    for (i = 0; i < f->map->size; i++) rsm__fill_texel(f, i, (uint32_t)row);
}

RSM_DEF rsm_result rsm_fill(rsm_map *map, uint32_t face, const rsm_buffers *buffers)
{
    const rsm_buffers *b = buffers;
    rsm__filling f;
    size_t i, texels;
    if (!map || !b || face >= map->faces || !b->normals || (!b->positions && !b->depth)) return RSM_ERR_ARGUMENT;
    if (map->finished) return RSM_ERR_ORDER;
    if (!rsm__stride_valid(b->position_stride, 12) || !rsm__stride_valid(b->depth_stride, 4)) return RSM_ERR_ARGUMENT;
    if (!rsm__stride_valid(b->normal_stride, 12) || !rsm__stride_valid(b->albedo_stride, 12)) return RSM_ERR_ARGUMENT;
    if (!rsm__stride_valid(b->material_stride, 4) || (b->srgb_stride != 0 && b->srgb_stride < 3))
        return RSM_ERR_ARGUMENT;
    f.map = map;
    f.face = face;
    f.buffers = b;
    for (i = 0; i < 256; i++) f.srgb[i] = rsm__from_srgb((uint8_t)i);
    if (rsm__run_steps(&map->desc.system, map->size, rsm__fill_row, &f, 0.0f, 1.0f)) return RSM_OK;
    texels = (size_t)map->size * map->size;
    for (i = 0; i < texels; i++) rsm__texel_clear(map->texels + face * texels + i);
    return RSM_ERR_CANCELLED;
}

RSM_DEF rsm_result rsm_rasterize(rsm_map *map, const rsm_mesh *meshes, size_t mesh_count)
{
    rsm__raster r;
    rsm__allocator a;
    rsm_result result;
    uint64_t skipped = 0;
    size_t i, texels;
    if (!map || (!meshes && mesh_count)) return RSM_ERR_ARGUMENT;
    if (map->finished) return RSM_ERR_ORDER;
    memset(&r, 0, sizeof r);
    r.map = map;
    r.meshes = meshes;
    r.mesh_count = mesh_count;
    result = rsm__meshes_check(&r, &skipped);
    if (result != RSM_OK) return result;
    a = rsm__allocator_of(&map->desc.system);
    texels = rsm__texel_count(map);
    r.boxes = (rsm__box *)rsm__alloc_array(&a, r.triangles + 1, sizeof *r.boxes);
    r.winners = (uint32_t *)rsm__alloc_array(&a, (size_t)map->size * map->size, sizeof *r.winners);
    for (i = 0; i < texels; i++) rsm__texel_clear(map->texels + i);
    result = r.boxes && r.winners ? rsm__raster_faces(&r) : RSM_ERR_ALLOC;
    for (i = 0; i < texels && result != RSM_OK; i++) rsm__texel_clear(map->texels + i);
    if (result == RSM_OK) map->stats.skipped_triangles = skipped;
    rsm__free(&a, r.winners);
    rsm__free(&a, r.boxes);
    return result;
}

RSM_DEF rsm_result rsm_finish(rsm_map *map, rsm_stats *stats)
{
    if (!map) return RSM_ERR_ARGUMENT;
    if (map->finished) return RSM_ERR_ORDER;
    rsm__sum_flux(map, stats != NULL);
    map->finished = 1;
    if (stats) *stats = map->stats;
    return RSM_OK;
}

/* >>> shared fp_end: written by tools/stamp from src/shared, edit there */

/* unit fp_end: the user's options again. clang and MSVC keep contraction off to the end of the file. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__)
#pragma GCC pop_options
#endif

/* <<< shared */

#endif /* RSM_IMPLEMENTATION */

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
