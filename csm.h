/* csm.h - v1.0.0 - coherent shadow maps: visibility of rigid objects, precomputed without loss - MIT-0 OR Unlicense

   What it does

   Renders an object's depth from thousands of directions (or light positions) once, compresses all those shadow maps
   into one small block, and answers "is this point lit from there?" with one cache line a query. After Ritschel,
   Grosch, Kautz and Mueller, "Interactive Illumination with Coherent Shadow Maps", EGSR 2007. On top of it: everything
   that a Monte Carlo renderer of direct light needs around visibility (environments, area lights, materials, sampling).

   What it does not do

   - Objects are rigid; they may move, turn and scale evenly. Nothing deforms.
   - Answers are exact for the maps, not for the scene: directions snap to N maps and points to M x M pixels. Shadows of
     details finer than a pixel (1/128 of the object) are lost or widened; docs/csm.md has pictures and figures.
   - No bounced light, no rendering, no file access, no threads of its own.

   Quick start

   In exactly one source file write the define; everywhere else include the header alone.

       #define CSM_IMPLEMENTATION
       #include "csm.h"
       #include <stdio.h>

       int main(void)
       {
           static const float corners[] = { -1, 0, -1,  1, 0, -1,  1, 0, 1,  -1, 0, 1 };    // a square
           static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2 };
           const float point[3] = { 0.0f, -0.5f, 0.0f }, sideways[3] = { 1, 0, 0 }, up[3] = { 0, 1, 0 };
           cohsm_mesh mesh = { corners, 4, 0, triangles, 6 };
           cohsm_query query = cohsm_query_default();
           cohsm_maps *maps;
           float lit[2];

           if (cohsm_build(NULL, &mesh, &maps, NULL) != COHSM_OK) return 1;     // 128 x 128 directions
           query.points = point;
           query.count = 1;
           query.lights = up;                                                   // towards the light
           cohsm_visible(maps, &query, &lit[0], NULL);
           query.lights = sideways;
           cohsm_visible(maps, &query, &lit[1], NULL);
           printf("below the square: light from above %g, from the side %g\n", (double)lit[0], (double)lit[1]);
           cohsm_free(maps);
           return !(lit[0] == 0.0f && lit[1] == 1.0f);
       }

   Real programs ask for thousands of points at once: the searches of a batch overlap, and one light for all points
   (query.one_light) is several times faster still.

   Conventions

   Right-handed; matrices are column-major float[16]; directions have unit length and point from the surface to the
   light; distances in the mesh's units, angles in radians, radiance in W/(sr m^2). Skies, latitude-longitude maps and
   `rotation` have their poles at +Y and -Y: a scene with Z up is turned before it comes here.

     map        the depth of the object along one direction (orthographic) or around one position (six faces of a cube)
     domain     the set of those directions or positions: a mapping D of d parameters in 0..1
     cell       one of the N samples of the domain; its map is what is precomputed
     view       one rendered image: a map, or one face of it; views are stored in a sequence chosen for coherence
     layers     z1, z2, z3: depths of the first hits of a pixel's ray
     segment    a run of views for which one stored depth separates z1 from the layer behind it
     receiver   the point that is asked about
     semi-local a light at a position outside the object's convex hull, answered by the maps of directions

   How it works

   A pixel's depth z may be stored as any value in [z1, z2): the comparison with a receiver on a surface comes out the
   same. For each pixel, the builder walks through the views and goes on with one value as long as it fits; that is the
   least number of segments. What it then writes is 14 to 16 bits a segment:

     lookup        4 bytes a pixel          directory     2 bytes a block of about 30 segments
     blocks        64 bytes: where each segment begins (Elias-Fano), and its depth (8-bit grid, range or palette)

   Memory is about M^2 s 1.9 bytes for s segments a pixel; s grows with about N^0.55 and with the object's detail (bunny
   345, dragon 530 at N = 128^2, M = 128). The knobs, and what each trades:

     side          fewer directions: banding in penumbrae, shadows that jump as a light moves
     map_size      fewer pixels: jagged and widened contact shadows; leaks through things thinner than a pixel. From
                   places on a light M pixels are 90 degrees: a small thing far from it wants maps of directions
     layers        Z1Z2 right everywhere; Z1Z3_SPHERE and Z1Z3_FAR halve and third the block, for closed objects, and
                   leak light onto receivers between the second and third surface, and with FAR behind the object
     bias          too little: acne at grazing light; too much: light leaks in corners. 1 pixel suits most
     filter        NEAREST is fastest and jagged; PCF smooth and slow; ROULETTE a search as NEAREST, noise for jags

   Configuration

     CSM_IMPLEMENTATION   in one source file: compiles the code
     CSM_STATIC           everywhere it is included: a private copy, all functions static
     COHSM_DEF            everywhere: your own linkage instead
     COHSM_NO_SIMD        with the implementation: portable code only (results are the same)

   Memory, errors, threads, determinism

   All memory comes from the allocator in the desc, called from the thread that called us. Every function that can fail
   returns a cohsm_result; where it is not COHSM_OK, outputs are untouched and nothing leaks. There are no globals:
   const maps may be queried from any number of threads; builders and progressive buffers belong to one at a time.
   Blocks built from the same input have the same bytes on every compiler, processor, byte order and thread count (not
   with x87 arithmetic, nor with clang's -ffast-math).

   Cost: docs/csm.md and build/bench csm_query, csm_compression. History: CHANGELOG.md. Licence: end of this file. */
#ifndef CSM_H
#define CSM_H

#define COHSM_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#include <stddef.h>
#include <stdint.h>

#ifndef COHSM_DEF
#ifdef CSM_STATIC
#define COHSM_DEF static inline
#else
#define COHSM_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- results ---- */

#define COHSM_RESULTS(X)                                                                                     \
    X(COHSM_OK, "ok")                                                                                        \
    X(COHSM_ERR_ARGUMENT, "an argument is NULL, zero, not finite or out of range")                           \
    X(COHSM_ERR_DESC, "a desc field is out of range")                                                        \
    X(COHSM_ERR_INPUT, "the mesh or layers cannot be used")                                                  \
    X(COHSM_ERR_ALLOC, "the allocator returned no memory")                                                   \
    X(COHSM_ERR_MEMORY, "the caller's buffer is too small or misaligned")                                    \
    X(COHSM_ERR_LIMIT, "a size overflows or passes a limit of the format")                                   \
    X(COHSM_ERR_CANCELLED, "cancelled by the progress callback")                                             \
    X(COHSM_ERR_ORDER, "views must come once each, in sequence")                                             \
    X(COHSM_ERR_FORMAT, "not a csm file, or a damaged one")                                                  \
    X(COHSM_ERR_VERSION, "a csm file of an unknown version")                                                 \
    X(COHSM_ERR_DOMAIN, "this call needs maps of another domain")                                            \
    X(COHSM_ERR_MISMATCH, "these shards do not belong together")

typedef enum cohsm_result {
#define COHSM__ENUM(name, text) name,
    COHSM_RESULTS(COHSM__ENUM)
#undef COHSM__ENUM
    COHSM_RESULT_COUNT
} cohsm_result;

COHSM_DEF const char *cohsm_result_text(cohsm_result result);
/* A constant string for any value, "unknown result" beyond the list. */

/* ---- memory, threads, progress: the caller's ---- */

typedef struct cohsm_allocator {    /* all zero = malloc and free; else both functions */
    void *(*alloc_fn)(size_t size, void *user);   /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} cohsm_allocator;

typedef void (*cohsm_task)(void *context, size_t index);
typedef void (*cohsm_parallel_for)(void *user, size_t count, cohsm_task task, void *context);
/* Must call task(context, i) once for each i < count, in any order and on any threads, and return when all are done. */

typedef int (*cohsm_progress)(void *user, float fraction);
/* Called between batches of views or lists, from the thread that called us, fraction 0..1 never falling, 0 while orders
   and frames are tried; not 0 cancels. */

/* ---- what is mapped: locations, layers, order ---- */

typedef struct cohsm_mesh {
    const float    *positions;      /* x, y, z of each vertex */
    size_t          vertex_count;
    size_t          vertex_stride;  /* bytes from one vertex to the next, a multiple of 4, >= 12; 0 = 12 */
    const uint32_t *indices;        /* three to a triangle; NULL = 0, 1, 2, ... */
    size_t          index_count;    /* a multiple of 3 (ignored without indices: vertex_count is used) */
} cohsm_mesh;

typedef enum cohsm_domain_kind {    /* D: [0,1]^d -> (x, y, z, w); w = 0 a direction to the light, w = 1 a position */
    COHSM_DOMAIN_DEFAULT,           /* = COHSM_DOMAIN_LATLONG */
    COHSM_DOMAIN_LATLONG,           /* d = 2, w = 0: s = 0.5 + atan2(z, x) / 2 pi, t = acos(y) / pi; row 0 is +Y */
    COHSM_DOMAIN_OCTAHEDRAL,        /* d = 2, w = 0: equal-area octahedral square (Clarberg 2008); side[0] = side[1] */
    COHSM_DOMAIN_LINE,              /* d = 1, w = 1: origin + s u */
    COHSM_DOMAIN_RECTANGLE,         /* d = 2, w = 1: origin + s u + t v */
    COHSM_DOMAIN_DISC,              /* d = 2, w = 1: centre origin, in the plane of u and v (its two half axes) */
    COHSM_DOMAIN_SPHERE,            /* d = 2, w = 1: surface of radius |u| about origin, lat-long of equal area */
    COHSM_DOMAIN_VOLUME,            /* d = 3, w = 1: origin + s u + t v + r w */
    COHSM_DOMAIN_TABLE,             /* d = 1..3: your own D at the cell centres, see locations */
    COHSM_DOMAIN_LIST,              /* d = 0: any set of locations (VPLs), asked by index, never interpolated */
    COHSM_DOMAIN_KIND_COUNT
} cohsm_domain_kind;

typedef struct cohsm_domain {
    cohsm_domain_kind kind;
    uint32_t side[3];               /* cells a dimension, 1..4096 (TABLE: 1..2^24), N = their product <= 2^24.
                                       0 = 128 (2-D), 32 (3-D) */
    float origin[3], u[3], v[3], w[3]; /* shape of the local kinds, in the mesh's space and units */
    const float *locations;         /* TABLE, LIST: x, y, z, w each; all w equal, 0 or 1. Copied */
    size_t location_count;          /* TABLE: the product of side; LIST: N, and side is ignored */
} cohsm_domain;

typedef enum cohsm_layers {         /* which interval [z1, upper) a stored depth may lie in */
    COHSM_LAYERS_DEFAULT,           /* = COHSM_LAYERS_Z1Z2 */
    COHSM_LAYERS_Z1Z2,              /* upper = second hit, or see open_thickness: right for every receiver */
    COHSM_LAYERS_Z1Z3_SPHERE,       /* third hit, or where the ray leaves the bounding sphere: closed surfaces only */
    COHSM_LAYERS_Z1Z3_FAR,          /* third hit, or infinity: closed, and nothing else behind */
    COHSM_LAYERS_COUNT
} cohsm_layers;

typedef enum cohsm_order {          /* of the maps; the longer neighbours look alike, the smaller the block */
    COHSM_ORDER_DEFAULT,            /* cohsm_build: by trial on small versions of the build (a fifth of its time); else
                                       Hilbert */
    COHSM_ORDER_SCANLINE,           /* first dimension fastest */
    COHSM_ORDER_ZIGZAG,             /* the same, every other line backwards */
    COHSM_ORDER_ZIGZAG_THETA,       /* zig-zag with the second dimension fastest */
    COHSM_ORDER_HILBERT,            /* any size; exact steps of 1 for powers of two */
    COHSM_ORDER_COUNT
} cohsm_order;

typedef enum cohsm_frame {          /* which way is up in the image of a direction's map */
    COHSM_FRAME_DEFAULT,            /* cohsm_build: by trial together with the order; else POLAR */
    COHSM_FRAME_POLAR,              /* right along rising s of LATLONG, up towards +Y */
    COHSM_FRAME_MINIMAL,            /* shortest rotation of the frame at +Y; turns fast near -Y */
    COHSM_FRAME_TWO_POLES,          /* shortest rotation from the nearer of +Y and -Y; jumps at the equator */
    COHSM_FRAME_COUNT
} cohsm_frame;

typedef struct cohsm_desc {
    cohsm_domain domain;
    uint32_t     map_size;          /* M, pixels a side of a map, 4..1024; 0 = 128 */
    cohsm_layers layers;
    cohsm_order  order;
    cohsm_frame  frame;             /* directions only */
    uint32_t     depth_bits;        /* grid of the stored depths, 4..8; 0 = 8. Depths that no grid value separates are
                                       kept in 16 bits, so this trades segments against bits and never exactness */
    float        open_thickness;    /* map pixels, >= 0; 0 = 8. How far behind a surface without a second hit (leaf,
                                       open border) its stored depth may lie, since receivers may be right behind it;
                                       map_size or more: as far as the bounding sphere goes, as in the paper */
    int          self_only;         /* not 0: pixels without a hit may store anything; smaller, for self-shadows only */
    float        center[3], radius; /* bounding sphere of the mesh; radius 0 = fitted (builder: required) */
    uint32_t     pixel_begin, pixel_end;   /* shard: lists of pixels begin..end-1 of the M * M; 0, 0 = all */
    cohsm_allocator    allocator;
    cohsm_parallel_for parallel_for;       /* NULL = this thread alone; the bytes built are the same */
    void              *parallel_user;
    cohsm_progress     progress;           /* NULL = none */
    void              *progress_user;
} cohsm_desc;                       /* zero it, then set what you care about */

typedef struct cohsm_stats {        /* of a build; every field may be read after COHSM_OK */
    uint64_t segments;              /* in all lists */
    uint64_t exact_depths;          /* segments of one map kept in 16 bits, no grid value lying in [z1, upper) */
    uint64_t empty_intervals;       /* entries with z1 = upper: stored z = z1, needs the bias */
    uint64_t open_entries;          /* entries with one hit only: an open border or a sheet was seen */
    uint32_t triangles;             /* used */
    uint32_t skipped_triangles;     /* a vertex not finite, or two corners equal */
    uint32_t duplicate_triangles;   /* same three corners as an earlier one, in any order */
    cohsm_order order;              /* the one taken */
    size_t   peak_bytes;            /* asked of the allocator at once */
} cohsm_stats;

/* ---- building ---- */

typedef struct cohsm_maps cohsm_maps;       /* one object's maps: a block of bytes and what was derived from it */

COHSM_DEF cohsm_result cohsm_build(const cohsm_desc *desc, const cohsm_mesh *mesh, cohsm_maps **out,
                                   cohsm_stats *stats);
/* Renders the layers of every map by the built-in rasteriser and compresses them.
   desc     NULL = all defaults
   out      written on COHSM_OK only; cohsm_free
   stats    may be NULL; written on COHSM_OK only
   Errors   COHSM_ERR_ARGUMENT, COHSM_ERR_DESC, COHSM_ERR_INPUT (stride, index beyond vertex_count, no usable triangle),
            COHSM_ERR_LIMIT, COHSM_ERR_ALLOC, COHSM_ERR_CANCELLED
   Cost     O(N (triangles + M^2)). Memory, n being the pixels of the shard: at most 100 bytes a triangle at first, then
            40; 32 views of 4 M^2 bytes (Z1Z2) or 8 M^2; 80 n; 4 N (20 N with locations); 16 bytes a segment of the last
            65,536 maps; and twice the block. The bytes built do not depend on compiler or threads. */

typedef struct cohsm_builder cohsm_builder; /* the same for layers from your own renderer, one view at a time */

typedef struct cohsm_view {         /* the camera of one map, or of one face of a cube */
    uint32_t index;                 /* 0..view count - 1, in sequence */
    uint32_t cell;                  /* which map, 0..N - 1, as cohsm_location counts */
    float matrix[16];               /* column-major; object space to x, y in 0..M (pixels, y up), z the linear depth in
                                       0..1; perspective faces give (x w, y w, -, w) with depth = w * depth_scale */
    float depth_scale;              /* perspective: depth = w * depth_scale; 0 for orthographic views */
    float location[4];              /* D of this view */
    uint32_t face;                  /* 0..5: +X -X +Y -Y +Z -Z; 0 for orthographic views */
} cohsm_view;

COHSM_DEF cohsm_result cohsm_builder_create(const cohsm_desc *desc, cohsm_builder **out);
COHSM_DEF uint32_t     cohsm_builder_view_count(const cohsm_builder *builder);   /* N, or 6 N for positions */
COHSM_DEF cohsm_result cohsm_builder_view(const cohsm_builder *builder, uint32_t index, cohsm_view *out);
COHSM_DEF cohsm_result cohsm_builder_add(cohsm_builder *builder, uint32_t index, const float *z1, const float *z2,
                                         const float *z3);
COHSM_DEF cohsm_result cohsm_builder_finish(cohsm_builder *builder, cohsm_maps **out, cohsm_stats *stats);
COHSM_DEF void         cohsm_builder_free(cohsm_builder *builder);      /* accepts NULL */
/* create   desc->radius must be > 0; desc->order must be a concrete one (DEFAULT = Hilbert)
   add      index counts up from 0; each of z1 <= z2 <= z3 is M * M depths in 0..1 (the view's z; row 0 is y = 0), or
            above 1 where there is no such hit; z3 may be NULL with COHSM_LAYERS_Z1Z2. NaN is COHSM_ERR_INPUT, and then
            the view may be given again
   finish   after the last view; the builder can only be destroyed after it, and after COHSM_ERR_ALLOC from add
   Errors   COHSM_ERR_ARGUMENT, COHSM_ERR_DESC, COHSM_ERR_ORDER, COHSM_ERR_INPUT, COHSM_ERR_LIMIT, COHSM_ERR_ALLOC
   Cost     memory as for cohsm_build, without the triangles; never the maps themselves.
   On a k-DOP: light refused by semi-local queries is then anything inside the bounding sphere. */

COHSM_DEF cohsm_result cohsm_merge(const cohsm_maps *const *shards, size_t count, const cohsm_desc *desc,
                                   cohsm_maps **out);
/* Joins shards of one desc whose pixel ranges follow each other from 0 to M * M; the bytes are those of the unsharded
   build.
   desc     for its allocator and progress only; may be NULL
   Errors   COHSM_ERR_ARGUMENT, COHSM_ERR_DESC (allocator), COHSM_ERR_MISMATCH, COHSM_ERR_LIMIT, COHSM_ERR_ALLOC,
            COHSM_ERR_CANCELLED */

COHSM_DEF void cohsm_free(cohsm_maps *maps);    /* accepts NULL */

/* ---- facts ---- */

typedef struct cohsm_info {
    cohsm_domain_kind domain;
    cohsm_layers layers;
    cohsm_order  order;
    cohsm_frame  frame;
    uint32_t side[3];
    uint32_t map_count;             /* N */
    uint32_t view_count;            /* N, or 6 N */
    uint32_t map_size;              /* M */
    uint32_t depth_bits;
    uint32_t dimensions;            /* d */
    int      positional;            /* w = 1 */
    int      self_only;
    uint32_t pixel_begin, pixel_end;
    float    center[3], radius;
    float    depth_far;             /* positional: distance that depth 1 stands for */
    uint64_t segments;
    size_t   bytes;                 /* of the block */
    double   ratio;                 /* view_count * pixels * 2 / bytes, as in the paper; pixels: M * M or a shard's */
} cohsm_info;

COHSM_DEF void cohsm_get_info(const cohsm_maps *maps, cohsm_info *out);

COHSM_DEF cohsm_result cohsm_location(const cohsm_maps *maps, uint32_t map, float out[4]);
/* D at the centre of cell map < N (cells counted with the first dimension fastest, not in the order of storage). */

/* ---- files ---- */

COHSM_DEF const void *cohsm_data(const cohsm_maps *maps, size_t *size);
/* The block: position-independent little-endian 32-bit words, the plain file format and what is uploaded. On
   big-endian hosts use cohsm_write. Valid as long as maps. */

COHSM_DEF cohsm_result cohsm_write(const cohsm_maps *maps, void *memory, size_t memory_size);
/* The bytes of the plain file, info.bytes of them, on a host of any byte order. */

COHSM_DEF cohsm_result cohsm_open(const void *data, size_t size, const cohsm_desc *desc, cohsm_maps **out);
/* Takes a plain or a packed file from memory: checks version, sizes, checksum and every list before anything is used,
   and copies it (data may go). Memory asked for: at most 64 bytes a byte of file + 256 KB.
   desc     for its allocator and progress only; may be NULL
   Errors   COHSM_ERR_ARGUMENT, COHSM_ERR_DESC (allocator), COHSM_ERR_FORMAT, COHSM_ERR_VERSION, COHSM_ERR_ALLOC,
            COHSM_ERR_CANCELLED */

COHSM_DEF cohsm_result cohsm_pack(const cohsm_maps *maps, const cohsm_desc *desc, void **data, size_t *size);
/* The packed file: the same block, entropy-coded against neighbouring pixels: about half of the plain size,
   of simple objects far less.
   desc     for its allocator and progress only; may be NULL
   data     written on COHSM_OK only, from desc's allocator: free it there
   Errors   COHSM_ERR_ARGUMENT, COHSM_ERR_DESC (allocator), COHSM_ERR_ALLOC, COHSM_ERR_LIMIT, COHSM_ERR_CANCELLED
   Cost     about 1 microsecond a segment, half of it to check that the file decodes to the same block; cohsm_open takes
            the other half. Memory: twice the block, and the packed file */

/* ---- checking a build ---- */

typedef struct cohsm_report {
    uint64_t entries;               /* pixels x views compared */
    uint64_t wrong;                 /* stored depth outside its interval; 0 or the block is not lossless */
    uint64_t empty;                 /* entries with z1 = upper, stored at z1 as promised */
    uint32_t first_view, first_pixel;   /* of the first wrong entry; the view in sequence, as cohsm_view.index */
} cohsm_report;

COHSM_DEF cohsm_result cohsm_verify(const cohsm_maps *maps, const cohsm_desc *desc, const cohsm_mesh *mesh,
                                    cohsm_report *out);
/* Renders every view of the mesh again and compares every stored value with max z1 <= z < upper (equation 1).
   desc     for its allocator, threads and progress only; may be NULL
   Errors   those of cohsm_build */

COHSM_DEF cohsm_result cohsm_depths(const cohsm_maps *maps, uint32_t view, uint16_t *out);
/* One map decompressed: view = cell, or face * N + cell; its stored depths z * 65533 of pixel_begin..pixel_end - 1 (all
   M * M unless maps is a shard), row 0 at y = 0; 65534 = open to the sphere's far side, 65535 = infinity. For tests,
   and for renderers that want one plain shadow map. Cost: M^2 searches. */

/* ---- queries: is the point lit? ---- */

typedef enum cohsm_light {
    COHSM_LIGHT_DIRECTION,          /* lights are unit directions to the light (x, y, z); maps of directions */
    COHSM_LIGHT_POSITION,           /* semi-local: positions in the space of the points, outside every instance's convex
                                       hull; maps of directions */
    COHSM_LIGHT_PARAMETER,          /* lights are d parameters in 0..1 of the maps' domain, any domain but LIST */
    COHSM_LIGHT_INDEX               /* lights are uint32_t cells < N, any domain; others count as lit */
} cohsm_light;

typedef enum cohsm_filter {
    COHSM_FILTER_NEAREST,           /* the nearest map, its nearest pixel: 0 or 1 */
    COHSM_FILTER_PCF,               /* 2^d maps x 4 pixels, weighted by distance: 0..1 (paper 4.5) */
    COHSM_FILTER_ROULETTE           /* one of those at random, its weight the probability: 0 or 1, same mean */
} cohsm_filter;

#define COHSM_NO_SELF UINT32_MAX    /* the point lies on no instance: a receiver only */
#define COHSM_REFUSED (-1.0f)       /* visibility of a sample whose light lies inside an instance's hull */

typedef struct cohsm_query {
    const float    *points;         /* x, y, z of each receiver, in world space (object space for cohsm_visible) */
    size_t          point_stride;   /* bytes, a multiple of 4, >= 12; 0 = 12 */
    size_t          count;
    const void     *lights;         /* see cohsm_light */
    size_t          light_stride;   /* bytes, a multiple of 4; 0 = packed: PARAMETER d floats, cohsm_samples.coords 3 */
    int             one_light;      /* not 0: lights is one element for all points. Much faster where points cluster */
    cohsm_light     light;
    cohsm_filter    filter;
    float           bias;           /* map pixels, >= 0: receivers count as that much nearer to the light */
    uint32_t        seed;           /* of COHSM_FILTER_ROULETTE; sample i draws from (seed, i, instance) */
    const uint32_t *self;           /* instance that each point lies on, tested first; beyond the list (COHSM_NO_SELF):
                                       none; NULL = none */
} cohsm_query;

COHSM_DEF cohsm_query cohsm_query_default(void);
/* All zero but the bias, which is 1 pixel: 0 is a bias too. */

COHSM_DEF cohsm_result cohsm_visible(const cohsm_maps *maps, const cohsm_query *query, float *visible,
                                     size_t *refused);
/* visible  count floats: 1 lit, 0 shadowed by this object, in between with PCF, COHSM_REFUSED
   refused  NULL, or receives the number of COHSM_REFUSED samples
   Errors   COHSM_ERR_ARGUMENT, COHSM_ERR_DOMAIN. Points and lights that are not finite, and
            directions of length 0, give 1: nothing is known there.
   Safe from several threads on the same maps. Cost: one list's block, about one cache miss, a sample; PCF 2^(d+2). */

typedef struct cohsm_instance {     /* an object of the scene; several may share maps */
    const cohsm_maps *maps;
    float transform[16];            /* object to world: rotation, one scale > 0, translation */
} cohsm_instance;

COHSM_DEF cohsm_result cohsm_visible_scene(const cohsm_instance *instances, size_t instance_count,
                                           const cohsm_query *query, float *visible, size_t *refused);
/* The product over all instances (paper 4.6): the point's own object first, then, while some light is left, the others.
   Roulette of instance i draws as if alone with seed + 0x9e3779b9 i.
   Errors   as cohsm_visible; COHSM_ERR_ARGUMENT also for transforms that shear, mirror or scale unevenly */

/* ---- choosing sizes ---- */

COHSM_DEF cohsm_result cohsm_budget(const cohsm_desc *desc, const cohsm_mesh *mesh, size_t bytes,
                                    uint32_t *side, uint32_t *map_size);
/* The side of LATLONG or OCTAHEDRAL and the map size M with the least expected error whose block stays below bytes.
   Sizes are measured on builds of side 16 and 32 and continued by their growth, with a tenth in reserve. The error is
   0.0055 (128 / side) + 0.0185 sqrt(128 / M): the shares of rays that snapping directions and pixels gets wrong on the
   bunny (docs/csm.md). desc's side and map_size are ignored.
   Errors   those of cohsm_build; COHSM_ERR_DOMAIN; COHSM_ERR_LIMIT where not even side 8, M = 16 fits
   Cost     about a build of side 40 */

/* ---- Sampling: the direct-light estimator of section 5 ---------------------------------------------------------

   L(x, wo) = integral of f(x, wo, w) L_in(x, w) V(x, w) cos(theta) dw, in three steps that arrays of points share:

       cohsm_sample      for each point S directions towards one light, each with its weight f L cos / (pdf S)
       a visibility query                    yours, or one of this header; a sample of weight 0 needs none
       cohsm_accumulate  adds weight x visibility up

   Several lights are several calls. Nothing here allocates; lights and patterns live in memory that you own. All
   vectors that must have unit length may be off by 1e-3. Every call is safe beside others on the same light. */

typedef enum cohsm_brdf {
    COHSM_BRDF_DEFAULT,          /* Lambert */
    COHSM_BRDF_LAMBERT,          /* diffuse / pi */
    COHSM_BRDF_PHONG,            /* + specular (n + 2) / (2 pi) cos^n(angle between w and the mirrored wo) */
    COHSM_BRDF_LAFORTUNE,        /* + sum over lobes of scale max(0, w . C wo)^n, Lafortune et al. 1997 */
    COHSM_BRDF_METAL_ROUGH       /* glTF: diffuse (1 - metallic) (1 - F) / pi + GGX, F0 = 0.04 to diffuse by metallic */
} cohsm_brdf;

#define COHSM_MAX_LOBES 8u

typedef struct cohsm_lobe {      /* in the frame tangent, bitangent, normal */
    float axis[3];               /* Cx, Cy, Cz: -1, -1, 1 mirrors; Cx != Cy needs a tangent */
    float exponent;              /* 0..1e5 */
    float scale[3];              /* >= 0, 1/sr */
} cohsm_lobe;

typedef struct cohsm_material {
    cohsm_brdf        type;
    float             diffuse[3];   /* albedo 0..1 (with specular <= 1 conserves energy); metal-rough: base colour */
    float             specular[3];  /* PHONG: albedo of the lobe seen along the normal, its largest; 0..1 */
    float             exponent;     /* PHONG: n, 0..1e5 */
    float             metallic;     /* METAL_ROUGH: 0..1 */
    float             roughness;    /* METAL_ROUGH: 0..1; alpha = roughness^2, not below 0.002 */
    const cohsm_lobe *lobes;        /* LAFORTUNE */
    uint32_t          lobe_count;   /* LAFORTUNE: 0..COHSM_MAX_LOBES */
} cohsm_material;

COHSM_DEF cohsm_result cohsm_brdf_eval(const cohsm_material *material, const float normal[3], const float tangent[3],
                                       const float wo[3], const float wi[3], float f[3], float *pdf);
/* f(wo, wi) without the cosine, in 1/sr, and the density per solid angle with which cohsm_brdf_sample returns wi.
   tangent  NULL: any; else unit, made orthogonal to normal
   wo, wi   unit, away from the surface; f = 0 where wi is below it, wo is lifted to just above it
   Errors   COHSM_ERR_DESC (material), COHSM_ERR_ARGUMENT (NULL, NaN, length) */

COHSM_DEF cohsm_result cohsm_brdf_sample(const cohsm_material *material, const float normal[3],
                                         const float tangent[3], const float wo[3], const float u[2], float wi[3],
                                         float f[3], float *pdf);
/* As above with wi chosen by u, both 0 <= u < 1: u[0] picks the lobe by Russian roulette and is then stretched to 0..1
   again. *pdf = 0: no sample (the lobe went below the surface, or the material is black); wi is the normal then. */

typedef enum cohsm_shape {       /* A: what emits, and its coordinates in [0, 1)^d, all of equal area */
    COHSM_SHAPE_DEFAULT,         /* environment */
    COHSM_SHAPE_ENVIRONMENT,     /* x = 0.5 + atan2(z, x) / (2 pi), y = acos(y) / pi: row 0 is +Y, the centre +X */
    COHSM_SHAPE_SUN,             /* one direction; no coordinates */
    COHSM_SHAPE_POINT,           /* no coordinates */
    COHSM_SHAPE_SPOT,            /* hard circular cone; no coordinates */
    COHSM_SHAPE_LINE,            /* cylinder without caps: x along it */
    COHSM_SHAPE_RECTANGLE,       /* position + x u + y v; emits along u x v */
    COHSM_SHAPE_DISC,            /* Shirley and Chiu's concentric map of the square; emits along direction */
    COHSM_SHAPE_SPHERE,          /* x as in the environment, y = (1 - cos of the angle from +Y) / 2; emits outwards */
    COHSM_SHAPE_CALLBACK,        /* shape_fn */
    COHSM_SHAPE_MESH             /* triangles that emit to where they turn counter-clockwise: x runs along a curve
                                    through them, in proportion to area; y and z lie in the piece that x names */
} cohsm_shape;

typedef void (*cohsm_shape_fn)(void *user, float time, const float x[3], float position[3], float normal[3],
                               float *area);
/* The surface point at x in [0, 1)^3, its emission side (0, 0, 0: a volume, emits without a cosine) and the Jacobian
   d area / dx there: its mean over the domain is the area (or volume). */

typedef void (*cohsm_emission_fn)(void *user, float time, const float x[3], const float direction[3], float rgb[3]);
/* Factor of the radiance that leaves the point x along the unit direction. For environments direction points from
   the surface to the sky. Values that are not finite or negative count as 0. */

typedef struct cohsm_emitter_desc {
    cohsm_shape       shape;
    float             position[3];  /* point, spot, disc, sphere: centre; rectangle: corner; line: start */
    float             direction[3]; /* sun: to it; spot: out of the lamp; disc: normal; unit */
    float             u[3], v[3];   /* rectangle: edges; line: u = end - start */
    float             radius;       /* disc, sphere, line: > 0; mesh: places of maps are this far off it, >= 0 */
    float             cone_angle;   /* spot: full apex angle, radians, 1e-6..pi */
    float             radiance[3];  /* L, W/(sr m^2); point and spot: I, W/sr; sun: E facing it, W/m^2; >= 0 */
    float             cosine_power; /* areas: L(theta) = radiance cos^power(theta); 0 is a Lambertian emitter */
    float             rotation;     /* environment: radians about +Y */
    const float      *texels;       /* L over [0, 1)^2: factors of radiance (set that to 1 1 1: with 0 all is black),
                                       height rows of width rgb texels, each constant; NULL: 1. Frames follow one
                                       another. Copied by cohsm_emitter_build */
    uint32_t          width, height;     /* a line has height 1; 0 without texels */
    uint32_t          frames;            /* 0 = 1 */
    float             frames_per_second; /* linear between frames; 0 = 30 */
    int               loop;              /* not 0: the frame after the last is the first; 0: the last stays */
    float             time;              /* seconds: the light is built as it is at this time */
    cohsm_shape_fn    shape_fn;
    cohsm_emission_fn emission_fn;       /* NULL: 1; not for sun, point and spot */
    void             *user;
    const cohsm_mesh *mesh;              /* MESH: in world space, no texels. Copied. Triangles not finite or without
                                            area do not emit */
    uint32_t          places;            /* MESH: of maps, 1..2^24; 0 = 1024. Twice as many pieces, or more */
} cohsm_emitter_desc;

typedef struct cohsm_emitter cohsm_emitter;

COHSM_DEF size_t cohsm_emitter_size(const cohsm_emitter_desc *desc);
/* Bytes that cohsm_emitter_build needs: at most 512 + 22 a texel + 26 a row + 4 a column; a mesh 64 a triangle and 272
   a place. 0: the desc is refused. */

COHSM_DEF cohsm_result cohsm_emitter_build(const cohsm_emitter_desc *desc, void *memory, size_t memory_size,
                                         cohsm_emitter **out, uint64_t *bad_texels);
/* memory      cohsm_emitter_size(desc) bytes, 8-byte aligned; must outlive *out
   bad_texels  may be NULL; texels of the frames in use with a channel that is not finite or negative: the channel is 0
   Errors      COHSM_ERR_DESC, COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_MEMORY, COHSM_ERR_INPUT (a mesh without area)
   A light that moves or changes is built again, for each frame if need be: O(texels). */

COHSM_DEF cohsm_result cohsm_emitter_domain(const cohsm_emitter *emitter, cohsm_domain *out);
/* D of section 4: the domain whose maps answer for samples of this emitter. Ask them with coords as
   COHSM_LIGHT_PARAMETER, light_stride 12; the sky's and the sun's, LATLONG, with directions; a point's and a spot's,
   LIST, by index 0.
   out      its side is 0, the default, but for a mesh's TABLE; locations of LIST and TABLE point into the emitter
   Errors   COHSM_ERR_ARGUMENT; COHSM_ERR_DOMAIN for callbacks: build a TABLE from shape_fn */

COHSM_DEF size_t cohsm_emitter_triangles(const cohsm_emitter *emitter, float *corners);
/* The pieces of a mesh in the order of its curve, equal in area within a factor of two unless triangles are smaller.
   corners  9 floats each; NULL = only count them. Returns their number, 0 for other shapes */

#define COHSM_INFINITY 340282346638528859811704183484516925440.0f   /* distance of sky and sun: the largest float */

typedef struct cohsm_emission {  /* one point of a light as seen from a point p */
    float direction[3];          /* unit, from p to it */
    float distance;              /* COHSM_INFINITY for environment and sun */
    float coords[3];             /* in [0, 1), the light's own coordinates; unused ones are 0 */
    float radiance[3];           /* towards p; sun, point, spot: irradiance facing it */
    float pdf;                   /* with which cohsm_emitter_sample returns it, per solid angle; sun, point, spot: 1 */
} cohsm_emission;

COHSM_DEF int cohsm_emitter_sample(const cohsm_emitter *light, const float p[3], const float u[3], cohsm_emission *out);
/* P_L: picks a point of the light in proportion to its texture, rectangles and spheres without one by solid angle.
   u are random numbers in [0, 1); u[2] serves callbacks only. Returns 0, *out untouched, where nothing reaches p. */

COHSM_DEF int cohsm_emitter_hit(const cohsm_emitter *light, const float p[3], const float direction[3],
                              cohsm_emission *out);
/* What a ray from p sees of the light alone. Returns 0, *out untouched, if it misses; always for sun, point, spot and
   callback, which have no area or none that is known, and for meshes, whose triangles a ray would have to search: those
   are only sampled from their side. */

typedef enum cohsm_sampling {
    COHSM_SAMPLING_DEFAULT,      /* both, weighted by the balance heuristic (Veach and Guibas 1995), shared out by
                                    solid angle of the light and width of the lobe */
    COHSM_SAMPLING_LIGHT,        /* P_L */
    COHSM_SAMPLING_BRDF,         /* P_f; sun, point, spot, callback and mesh: P_L all the same */
    COHSM_SAMPLING_PAPER         /* environment: the diffuse part by P_L, the specular one by P_f, roulette between them
                                    by k_d, the diffuse share of the albedo; every other light by P_L */
} cohsm_sampling;

typedef struct cohsm_points {    /* strides in bytes, multiples of 4; 0 = 12 */
    size_t                count;
    const float          *positions;  size_t position_stride;  /* 3 floats, world space */
    const float          *normals;    size_t normal_stride;    /* 3 floats, unit shading normals */
    const float          *views;      size_t view_stride;      /* 3 floats, unit, to the eye; NULL = normals */
    const float          *tangents;   size_t tangent_stride;   /* 3 floats, unit; NULL = any */
    const cohsm_material *materials;  size_t material_stride;  /* 0: one for all; else sizeof or above,
                                                                         a multiple of sizeof(void *) */
    const uint32_t       *pixels;     /* y * width + x, picks the random numbers; NULL: 0, 1, ... */
} cohsm_points;

typedef struct cohsm_sample_desc {
    uint32_t       samples;      /* S for each point, 1..65536 */
    cohsm_sampling sampling;
    uint32_t       seed;         /* another seed, other noise: use one for each light */
    uint32_t       frame;        /* of progressive rendering: frame i goes on where frame i - 1 stopped */
    const float   *patterns;     /* from cohsm_patterns_build with length S; NULL: a scrambled (0, 2)-sequence a pixel,
                                    which converges faster over many frames */
} cohsm_sample_desc;

typedef struct cohsm_samples {   /* room for count * S each; sample k of point i is number i S + k */
    float *directions;           /* 3 floats, unit; the normal where the weight is 0 and no direction was found */
    float *distances;            /* COHSM_INFINITY for distant lights. Positions: point + distance direction */
    float *coords;               /* 3 floats, of the light; NULL: not wanted */
    float *weights;              /* 3 floats: f L cos / (pdf S) */
} cohsm_samples;

COHSM_DEF cohsm_result cohsm_sample(const cohsm_sample_desc *desc, const cohsm_emitter *light,
                                    const cohsm_points *points, const cohsm_samples *out, size_t *useful);
/* useful  may be NULL; number of samples whose weight is not 0: only these need visibility
   Errors  COHSM_ERR_DESC (desc, a material), COHSM_ERR_ARGUMENT (NULL, stride, NaN, length); outputs are then untouched
   Cost    O(count S); a point's samples depend on its own inputs and pixel only, so that batches may be cut anywhere */

COHSM_DEF cohsm_result cohsm_accumulate(size_t count, uint32_t samples, const float *weights, const float *visibility,
                                        float *radiance, size_t radiance_stride);
/* radiance[i] += sum over k of weights[i S + k] visibility[i S + k], 3 floats radiance_stride bytes apart (0 = 12).
   visibility  one float for each sample, 0..1; NULL: all lit. COHSM_REFUSED counts as 0
   Errors      COHSM_ERR_ARGUMENT */

#define COHSM_PATTERN_COUNT 256u

COHSM_DEF size_t cohsm_patterns_size(uint32_t length);
/* Bytes of COHSM_PATTERN_COUNT patterns of length points in the unit square; 0 if length is not 1..65536. */

COHSM_DEF cohsm_result cohsm_patterns_build(uint32_t length, uint32_t seed, float *patterns, size_t size);
/* Section 5.1: pattern j holds its points at patterns + j * length * 2. Each of the length columns of the square holds
   one point, jittered; so does each cell of the square grid where length is a power of 4.
   cohsm_sample takes the pattern by pixel and moves to another one each frame; after 256 frames all have been used and
   return shifted. */

typedef struct cohsm_progressive { /* section 5.2: the mean of frames; sums are doubles, good for 1e6 frames */
    double  *sums;               /* count doubles of yours */
    size_t   count;              /* 3 x pixels */
    uint32_t frames;             /* in the sums */
} cohsm_progressive;

COHSM_DEF cohsm_result cohsm_progressive_reset(cohsm_progressive *p);
/* Forgets all frames: after every change of camera, scene or light. */
COHSM_DEF cohsm_result cohsm_progressive_add(cohsm_progressive *p, const float *frame);
/* Adds a frame of count floats. */
COHSM_DEF cohsm_result cohsm_progressive_mean(const cohsm_progressive *p, float *mean);
/* Writes count floats; COHSM_ERR_ARGUMENT before the first frame. */

#ifdef __cplusplus
}
#endif

#endif /* CSM_H */

/* ==== implementation ============================================================================================== */

#if defined(CSM_IMPLEMENTATION) && !defined(CSM_IMPLEMENTED)
#define CSM_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifdef COHSM_NO_SIMD
#define COHSM__NO_SIMD
#endif

/* >>> shared fp_begin mem v3 m4 bytes crc trig octa hilbert rng lds cdf cpu bits part: by tools/stamp of src/shared */

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

typedef struct cohsm__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} cohsm__allocator;

static inline void *cohsm__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void cohsm__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* *out = a * b and 1, or 0 and *out untouched where the product does not fit. */
static inline int cohsm__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

static inline int cohsm__add_size(size_t a, size_t b, size_t *out)
{
    if (a > SIZE_MAX - b) return 0;
    *out = a + b;
    return 1;
}

/* Bytes between elements of floats that are `standard` large: 0 stands for that; else they do not overlap. */
static inline int cohsm__stride_valid(size_t stride, size_t standard)
{
    return stride == 0 || (stride >= standard && stride % 4 == 0);
}

/* Takes the members of a public desc. Both functions or none: valid() is what the desc check asks. */
static inline int cohsm__allocator_valid(void *(*alloc_fn)(size_t, void *), void (*free_fn)(void *, void *))
{
    return (alloc_fn == NULL) == (free_fn == NULL);
}

static inline cohsm__allocator cohsm__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    cohsm__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : cohsm__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : cohsm__default_free;
    a.user = user;
    return a;
}

/* NULL where the size is 0 or overflows, so that a caller has one thing to test. */
static inline void *cohsm__alloc(const cohsm__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *cohsm__alloc_array(const cohsm__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return cohsm__mul_size(count, item_size, &size) ? cohsm__alloc(a, size) : NULL;
}

static inline void cohsm__free(const cohsm__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* unit v3: three floats */

/* tcc 0.9.27 stores a returned struct of 12 bytes as 16, over the caller's next variable. */
typedef struct cohsm__v3 {
    float x, y, z;
#ifdef __TINYC__
    float unused;
#endif
} cohsm__v3;

static inline cohsm__v3 cohsm__v3_make(float x, float y, float z)
{
    cohsm__v3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

static inline cohsm__v3 cohsm__v3_load(const float *p) { return cohsm__v3_make(p[0], p[1], p[2]); }
static inline void cohsm__v3_store(float *p, cohsm__v3 v) { p[0] = v.x; p[1] = v.y; p[2] = v.z; }

static inline cohsm__v3 cohsm__v3_add(cohsm__v3 a, cohsm__v3 b)
{
    return cohsm__v3_make(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline cohsm__v3 cohsm__v3_sub(cohsm__v3 a, cohsm__v3 b)
{
    return cohsm__v3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline cohsm__v3 cohsm__v3_mul(cohsm__v3 a, cohsm__v3 b)
{
    return cohsm__v3_make(a.x * b.x, a.y * b.y, a.z * b.z);
}

static inline cohsm__v3 cohsm__v3_scale(cohsm__v3 a, float s)
{
    return cohsm__v3_make(a.x * s, a.y * s, a.z * s);
}

/* a + b s */
static inline cohsm__v3 cohsm__v3_madd(cohsm__v3 a, cohsm__v3 b, float s)
{
    return cohsm__v3_make(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s);
}

static inline float cohsm__v3_dot(cohsm__v3 a, cohsm__v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float cohsm__v3_length(cohsm__v3 a)
{
    return sqrtf(cohsm__v3_dot(a, a));
}

static inline cohsm__v3 cohsm__v3_cross(cohsm__v3 a, cohsm__v3 b)
{
    return cohsm__v3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline cohsm__v3 cohsm__v3_min(cohsm__v3 a, cohsm__v3 b)
{
    return cohsm__v3_make(a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z);
}

static inline cohsm__v3 cohsm__v3_max(cohsm__v3 a, cohsm__v3 b)
{
    return cohsm__v3_make(a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z);
}

/* Scaled by the largest component first, so that neither tiny nor huge vectors leave the float range.
   The zero vector stays zero. */
static inline cohsm__v3 cohsm__v3_normalize(cohsm__v3 a)
{
    float x = fabsf(a.x), y = fabsf(a.y), z = fabsf(a.z), m = x > y ? x : y;
    m = m > z ? m : z;
    if (!(m > 0.0f)) return cohsm__v3_make(0.0f, 0.0f, 0.0f);
    if (m < 1e-30f) {
        a = cohsm__v3_scale(a, 1e30f);
        m *= 1e30f;
    }
    a = cohsm__v3_make(a.x / m, a.y / m, a.z / m);
    m = cohsm__v3_length(a);
    return cohsm__v3_make(a.x / m, a.y / m, a.z / m);
}

/* By the exponent bits, because compilers may take isfinite() for always true under -ffast-math. */
static inline int cohsm__finite(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7f800000u) != 0x7f800000u;
}

static inline int cohsm__in(float x, float low, float high) { return cohsm__finite(x) && x >= low && x <= high; }

static inline int cohsm__v3_finite(cohsm__v3 a)
{
    return cohsm__finite(a.x) && cohsm__finite(a.y) && cohsm__finite(a.z);
}

/* b1, b2, n right-handed and orthonormal for a unit n. Duff et al., "Building an orthonormal basis, revisited",
   JCGT 6(1), 2017; n.z = -0 and n.z = -1 included. */
static inline void cohsm__v3_basis(cohsm__v3 n, cohsm__v3 *b1, cohsm__v3 *b2)
{
    float s = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + n.z), b = n.x * n.y * a;
    *b1 = cohsm__v3_make(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
    *b2 = cohsm__v3_make(b, s + n.y * n.y * a, -n.y);
}

/* unit m4, needs v3: column-major 4 x 4 matrices, float[16], affine */

static inline cohsm__v3 cohsm__m4_point(const float *m, cohsm__v3 p)
{
    return cohsm__v3_make(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12], m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                     m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]);
}

static inline cohsm__v3 cohsm__m4_direction(const float *m, cohsm__v3 d)
{
    return cohsm__v3_make(m[0] * d.x + m[4] * d.y + m[8] * d.z, m[1] * d.x + m[5] * d.y + m[9] * d.z,
                     m[2] * d.x + m[6] * d.y + m[10] * d.z);
}

/* Finite, with 0 0 0 1 as its last row. */
static inline int cohsm__m4_is_affine(const float *m)
{
    int i;
    for (i = 0; i < 16; i++)
        if (!cohsm__finite(m[i])) return 0;
    return m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f && m[15] == 1.0f;
}

/* out = m^-1 and 1; 0 and out untouched where m is singular to float precision: the determinant against the product
   of the column lengths, so that the test is free of scale. In double: the inverse of a badly scaled matrix is used
   on points. out may be m. */
static inline int cohsm__m4_affine_inverse(float *out, const float *m)
{
    double a = (double)m[0], b = (double)m[4], c = (double)m[8];
    double d = (double)m[1], e = (double)m[5], f = (double)m[9];
    double g = (double)m[2], h = (double)m[6], k = (double)m[10];
    double tx = (double)m[12], ty = (double)m[13], tz = (double)m[14];
    double ca = e * k - f * h, cb = f * g - d * k, cc = d * h - e * g;
    double det = a * ca + b * cb + c * cc;
    double size = sqrt((a * a + d * d + g * g) * (b * b + e * e + h * h)) * sqrt(c * c + f * f + k * k);
    double r[12];
    int i;

    if (!(det > 1e-7 * size || det < -1e-7 * size)) return 0;
    r[0] = ca / det;
    r[1] = cb / det;
    r[2] = cc / det;
    r[3] = (c * h - b * k) / det;
    r[4] = (a * k - c * g) / det;
    r[5] = (b * g - a * h) / det;
    r[6] = (b * f - c * e) / det;
    r[7] = (c * d - a * f) / det;
    r[8] = (a * e - b * d) / det;
    for (i = 0; i < 3; i++) r[9 + i] = -(r[i] * tx + r[3 + i] * ty + r[6 + i] * tz);
    for (i = 0; i < 12; i++)
        if (!cohsm__finite((float)r[i])) return 0;
    for (i = 0; i < 4; i++) {
        out[4 * i] = (float)r[3 * i];
        out[4 * i + 1] = (float)r[3 * i + 1];
        out[4 * i + 2] = (float)r[3 * i + 2];
        out[4 * i + 3] = i == 3 ? 1.0f : 0.0f;
    }
    return 1;
}

/* 1 and *scale where m is a rotation times one scale > 0 (no mirroring) plus a translation: columns of equal length
   and at right angles within 1e-4, which is what products of float rotations reach. */
static inline int cohsm__m4_is_rigid_uniform(const float *m, float *scale)
{
    cohsm__v3 x = cohsm__v3_load(m), y = cohsm__v3_load(m + 4), z = cohsm__v3_load(m + 8);
    float s, lx, ly, lz, tolerance;

    if (!cohsm__m4_is_affine(m)) return 0;
    lx = cohsm__v3_length(x);
    ly = cohsm__v3_length(y);
    lz = cohsm__v3_length(z);
    if (!(lx > 0.0f && ly > 0.0f && lz > 0.0f) || !cohsm__finite(lx + ly + lz)) return 0;
    s = (lx + ly + lz) / 3.0f;
    tolerance = 1e-4f * s;
    if (fabsf(lx - s) > tolerance || fabsf(ly - s) > tolerance || fabsf(lz - s) > tolerance) return 0;
    x = cohsm__v3_scale(x, 1.0f / lx);
    y = cohsm__v3_scale(y, 1.0f / ly);
    z = cohsm__v3_scale(z, 1.0f / lz);
    if (fabsf(cohsm__v3_dot(x, y)) > 1e-4f || fabsf(cohsm__v3_dot(x, z)) > 1e-4f) return 0;
    if (fabsf(cohsm__v3_dot(y, z)) > 1e-4f || cohsm__v3_dot(cohsm__v3_cross(x, y), z) < 0.0f) return 0;
    *scale = s;
    return 1;
}

/* unit bytes: little-endian values in byte arrays, whatever the host's order and alignment */

static inline void cohsm__put_u16(uint8_t *p, uint32_t v)
{
    p[0] = (uint8_t)(v & 255u);
    p[1] = (uint8_t)(v >> 8 & 255u);
}

static inline void cohsm__put_u32(uint8_t *p, uint32_t v)
{
    cohsm__put_u16(p, v & 0xffffu);
    cohsm__put_u16(p + 2, v >> 16);
}

static inline uint32_t cohsm__get_u32(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static inline int cohsm__host_is_little_endian(void)
{
    uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 1;
}

/* unit crc: CRC-32 as in zip and PNG (reflected 0xEDB88320) */

/* Begin with crc = 0 and go on with the last result. A table of 16: a nibble a step is fast enough for files and small
   enough to read. */
static inline uint32_t cohsm__crc32(uint32_t crc, const void *data, size_t size)
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

static inline float cohsm__from_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline uint32_t cohsm__to_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* |x| with the sign bit of s; s = -0 counts as negative. */
static inline float cohsm__copysign(float x, float s)
{
    return cohsm__from_bits((cohsm__to_bits(x) & 0x7fffffffu) | (cohsm__to_bits(s) & 0x80000000u));
}

/* a where yes is 1, b where it is 0, both computed: compilers turn a chain of ?: with one condition into a branch, and
   then do not vectorise the loop round it. */
static inline float cohsm__either(int yes, float a, float b)
{
    uint32_t mask = 0u - (uint32_t)yes;
    return cohsm__from_bits((cohsm__to_bits(a) & mask) | (cohsm__to_bits(b) & ~mask));
}

/* Cody and Waite: pi/2 in three parts, of which the first two times k are exact for |k| < 2^13. |x| <= 8192: error 1e-7
   absolute. */
static inline void cohsm__sincos(float x, float *sine, float *cosine)
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

static inline float cohsm__cos(float x)
{
    float s, c;
    cohsm__sincos(x, &s, &c);
    return c;
}

/* asin of 0 <= x <= 0.5, z = x * x. What is made of it: error 3e-7 absolute. */
static inline float cohsm__asin_core(float x, float z)
{
    return x + x * z * (0.1666675393f + z * (0.07495241769f + z * (0.04547709903f + z * (0.02414760004f +
                        z * 0.04221856856f))));
}

/* Above a half by asin(x) = pi/2 - 2 asin(sqrt((1 - x) / 2)), which keeps acos exact near 0. The square root apart,
   since C compilers do not vectorise that one: acos(x) = cohsm__acos_rooted(x, sqrtf(cohsm__acos_square(x))). */
static inline float cohsm__acos_square(float x)
{
    float a = fabsf(x);
    return 0.5f * (1.0f - cohsm__either(a < 1.0f, a, 1.0f));
}

static inline float cohsm__acos_rooted(float x, float root)
{
    float a = fabsf(x), h = cohsm__acos_square(x), p;
    int big = a > 0.5f;
    a = cohsm__either(a < 1.0f, a, 1.0f);
    p = cohsm__asin_core(cohsm__either(big, root, a), cohsm__either(big, h, a * a));
    p = cohsm__either(big, 2.0f * p, 1.57079633f - p);
    return cohsm__either(x < 0.0f, 3.14159265f - p, p);
}

static inline float cohsm__acos(float x) { return cohsm__acos_rooted(x, sqrtf(cohsm__acos_square(x))); }

/* All quadrants, zeros of either sign and infinities as C's atan2f; atan2(0, 0) = 0. Error 4e-7 absolute, 3 ulp. */
static inline float cohsm__atan2(float y, float x)
{
    float ax = fabsf(x), ay = fabsf(y), a, t, z, p;
    float hi = cohsm__either(ax > ay, ax, ay), lo = cohsm__either(ax > ay, ay, ax);
    int big;
    a = cohsm__either((lo == hi) & (hi > 0.0f), 1.0f, lo / cohsm__either(hi > 0.0f, hi, 1.0f));
    big = a > 0.414213562f;
    t = cohsm__either(big, (a - 1.0f) / (a + 1.0f), a);
    z = t * t;
    p = t + t * z * (-0.3333295525f + z * (0.1997792608f + z * (-0.1387984996f + z * 0.08060308882f)));
    p = cohsm__either(big, p + 0.785398163f, p);
    p = cohsm__either(ay > ax, 1.57079633f - p, p);
    p = cohsm__either((int)(cohsm__to_bits(x) >> 31), 3.14159265f - p, p);
    return cohsm__copysign(p, y);
}

/* 2^k (1 + r + r^2 p(r)), |r| <= ln 2 / 2, in double: exp, log and pow err by 1 ulp. */
static inline double cohsm__exp_core(double x)
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
static inline double cohsm__log_core(float x)
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

/* x below 0 counts as 0; pow(0, y) is 0, 1 or infinity for y above, equal to or below 0. */
static inline float cohsm__pow(float x, float y)
{
    double t;
    if (y == 0.0f) return 1.0f;
    if (!(x > 0.0f)) return y > 0.0f ? 0.0f : cohsm__from_bits(0x7f800000u);
    t = (double)y * cohsm__log_core(x);
    return t > 88.722839111 ? cohsm__from_bits(0x7f800000u) : (float)cohsm__exp_core(t);
}

/* unit octa, needs v3 trig: equal-area map between the unit square and the sphere, +Y at its centre */

/* Clarberg, "Fast equal-area mapping of the (hemi)sphere using SIMD", J. Graphics Tools 13(3), 2008. The inner diamond
   is the hemisphere y >= 0; neighbouring cells of the square are neighbours on the sphere. */
static inline cohsm__v3 cohsm__octa_direction(float u, float v)
{
    float a = 2.0f * u - 1.0f, b = 2.0f * v - 1.0f, x = fabsf(a), z = fabsf(b);
    float d = 1.0f - (x + z), r = 1.0f - fabsf(d), s, c, f;

    cohsm__sincos(r > 0.0f ? ((z - x) / r + 1.0f) * 0.785398163f : 0.0f, &s, &c);
    f = r * sqrtf(2.0f - r * r);
    return cohsm__v3_make(a < 0.0f ? -f * c : f * c, d < 0.0f ? r * r - 1.0f : 1.0f - r * r,
                     b < 0.0f ? -f * s : f * s);
}

/* n of unit length. 1 - |y| by x^2 + z^2, which is exact near the poles. u and v in [0, 1]. */
static inline void cohsm__octa_square(cohsm__v3 n, float *u, float *v)
{
    float r = sqrtf((n.x * n.x + n.z * n.z) / (1.0f + fabsf(n.y)));
    float b = cohsm__atan2(fabsf(n.z), fabsf(n.x)) * 0.636619772f * r, a = r - b, t = a;

    if (n.y < 0.0f) {
        a = 1.0f - b;
        b = 1.0f - t;
    }
    a = a < 0.0f ? 0.0f : a > 1.0f ? 1.0f : a;
    b = b < 0.0f ? 0.0f : b > 1.0f ? 1.0f : b;
    *u = 0.5f * (n.x < 0.0f ? 1.0f - a : 1.0f + a);
    *v = 0.5f * (n.z < 0.0f ? 1.0f - b : 1.0f + b);
}

/* unit hilbert: Hilbert curves in 1 to 3 dimensions */

/* Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707, 2004: the index's bits dealt out to the axes are
   Gray-decoded, then exchanges and inversions are undone from the finest level up. A cube of 2^bits cells a side,
   dims * bits <= 32; index < 2^(dims * bits), cell[i] < 2^bits. Neighbours on the curve share a face. */
static inline void cohsm__hilbert_cell(uint32_t index, uint32_t bits, uint32_t dims, uint32_t *cell)
{
    uint32_t i, b, q, t;

    for (i = 0; i < dims; i++) {
        cell[i] = 0;
        for (b = 0; b < bits; b++) cell[i] |= (index >> (b * dims + (dims - 1u - i)) & 1u) << b;
    }
    t = cell[dims - 1u] >> 1;
    for (i = dims - 1u; i > 0; i--) cell[i] ^= cell[i - 1u];
    cell[0] ^= t;
    for (b = 1; b < bits; b++) {
        q = (1u << b) - 1u;
        for (i = dims; i-- > 0;) {
            t = cell[i] >> b & 1u ? 0u : (cell[0] ^ cell[i]) & q;
            cell[0] ^= cell[i] >> b & 1u ? q : t;
            cell[i] ^= t;
        }
    }
}

static inline uint32_t cohsm__hilbert_index(const uint32_t *cell, uint32_t bits, uint32_t dims)
{
    uint32_t x[3] = { 0, 0, 0 }, i, b, q, t, index = 0;

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

/* unit rng: hashes and random numbers, the same on every machine */

/* Jarzynski and Olano, "Hash functions for GPU rendering", JCGT 9(3), 2020: the output function of O'Neill's PCG. */
static inline uint32_t cohsm__hash32(uint32_t x)
{
    uint32_t state = x * 747796405u + 2891336453u;
    uint32_t word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

static inline uint32_t cohsm__hash_combine(uint32_t a, uint32_t b)
{
    return cohsm__hash32(a + 0x9e3779b9u * cohsm__hash32(b));
}

/* The upper 24 bits: every value is a float, the largest is 1 - 2^-24. */
static inline float cohsm__to_unit(uint32_t bits) { return (float)(bits >> 8) * (1.0f / 16777216.0f); }

/* Number i of the stream (seed, stream), in [0, 1), without state: what threads and tiles need. */
static inline float cohsm__random(uint32_t seed, uint32_t stream, uint32_t i)
{
    return cohsm__to_unit(cohsm__hash_combine(cohsm__hash_combine(seed, stream), i));
}

/* unit lds, needs rng: low-discrepancy points in [0, 1) */

static inline uint32_t cohsm__reverse_bits(uint32_t x)
{
    x = x >> 16 | x << 16;
    x = (x >> 8 & 0x00ff00ffu) | (x & 0x00ff00ffu) << 8;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    return (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
}

/* Owen scrambling by the hash of Laine and Karras as Burley tuned it, "Practical hash-based Owen scrambling",
   JCGT 9(4), 2020. Works on reversed bits: a bit depends on the more significant ones only. */
static inline uint32_t cohsm__owen(uint32_t x, uint32_t seed)
{
    x = cohsm__reverse_bits(x) + seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return cohsm__reverse_bits(x);
}

/* Point i of a scrambled (0, 2)-sequence: the first two dimensions of Sobol's. The order is shuffled too, so that
   different seeds may be combined to more dimensions. */
static inline void cohsm__sobol2(uint32_t i, uint32_t seed, float *u, float *v)
{
    uint32_t x, y = 0, d = 0x80000000u, k;
    i = cohsm__owen(i, cohsm__hash32(seed));
    x = cohsm__reverse_bits(i);
    for (k = i; k; k >>= 1, d ^= d >> 1)
        if (k & 1u) y ^= d;
    *u = cohsm__to_unit(cohsm__owen(x, cohsm__hash_combine(seed, 1u)));
    *v = cohsm__to_unit(cohsm__owen(y, cohsm__hash_combine(seed, 2u)));
}

/* unit cdf: piecewise-constant distributions in 1D and 2D, sampled by inversion */

/* Running sums in double: a float sum of 1e6 small weights is wrong in the third digit. sums[i] is the weight before
   cell i, sums[count] the total; the array is the caller's. */
typedef struct cohsm__cdf { const double *sums; uint32_t count; } cohsm__cdf;

/* Negative, NaN and infinite weights count as 0; their number is returned. scale is 1 for most callers. */
static inline size_t cohsm__cdf_build(cohsm__cdf *cdf, double *sums, const float *weights, uint32_t count, double scale)
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

static inline double cohsm__cdf_total(const cohsm__cdf *cdf) { return cdf->sums[cdf->count]; }

/* Rows first: marginal over the rows, then the row's own distribution. */
typedef struct cohsm__cdf2 { const double *rows, *sums; uint32_t width, height; } cohsm__cdf2;

/* Doubles for width * height cells; 0 where that overflows. */
static inline size_t cohsm__cdf2_doubles(uint32_t width, uint32_t height)
{
    size_t row = (size_t)width + 1u, rows = (size_t)height + 1u;
    if (row == 0 || rows == 0 || height > (SIZE_MAX / sizeof(double) - rows) / row) return 0;
    return row * height + rows;
}

static inline double cohsm__cdf2_total(const cohsm__cdf2 *cdf) { return cdf->rows[cdf->height]; }

/* unit cpu: run-time detection of x86 vector units */

/* COHSM__X86 is 1 where functions with target attributes can be compiled and chosen at run time.
   COHSM__NO_SIMD, defined by the header from its public switch, leaves all of it out. tcc has no attributes; MSVC
   needs none. clang in MSVC's place (clang-cl) hides the vector types unless all is built for them. */
#if !defined(COHSM__NO_SIMD) && (defined(__x86_64__) || defined(__i386__)) && defined(__GNUC__) && !defined(__TINYC__)
#define COHSM__X86 1
#define COHSM__TARGET_AVX2 __attribute__((target("avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#define COHSM__TARGET_AVX512 \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#elif !defined(COHSM__NO_SIMD) && defined(_MSC_VER) && defined(_M_X64) && !defined(__clang__)
#define COHSM__X86 1
#define COHSM__TARGET_AVX2
#define COHSM__TARGET_AVX512
#else
#define COHSM__X86 0
#endif

#if COHSM__X86 && defined(_MSC_VER)
#include <intrin.h>
/* Bit of leaf 7's ebx, after FMA and what the operating system saves were checked. */
static inline int cohsm__cpu_leaf7(unsigned xcr0, unsigned ebx)
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
static inline int cohsm__cpu_has_avx2(void) { return cohsm__cpu_leaf7(0x06u, 0x00000128u); }
static inline int cohsm__cpu_has_avx512(void) { return cohsm__cpu_leaf7(0xe6u, 0xc0030128u); }
#elif COHSM__X86
/* The compiler's run time asks the operating system too. Every processor with BMI2 has LZCNT. */
static inline int cohsm__cpu_has_avx2(void)
{
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
           __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
}
static inline int cohsm__cpu_has_avx512(void)
{
    return cohsm__cpu_has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}
#else
static inline int cohsm__cpu_has_avx2(void) { return 0; }
static inline int cohsm__cpu_has_avx512(void) { return 0; }
#endif

/* unit bits: counting bits */

static inline uint32_t cohsm__popcount(uint64_t x)
{
    x -= x >> 1 & 0x5555555555555555u;
    x = (x & 0x3333333333333333u) + (x >> 2 & 0x3333333333333333u);
    x = (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    return (uint32_t)(x * 0x0101010101010101u >> 56);
}

/* unit part: the caller's progress within parts of a call, and whether it cancels */

/* progress may be NULL; from..to of 0..1. */
typedef struct cohsm__part {
    int (*progress)(void *user, float fraction);
    void *user;
    float from, to;
} cohsm__part;

/* Where progress is not NULL; fraction: of the part. */
static inline int cohsm__part_tell(const cohsm__part *p, float fraction)
{
    return p->progress(p->user, p->from + (p->to - p->from) * fraction);
}

static inline cohsm__part cohsm__part_of(const cohsm__part *whole, float from, float to)
{
    cohsm__part p = *whole;
    p.from = whole->from + (whole->to - whole->from) * from;
    p.to = whole->from + (whole->to - whole->from) * to;
    return p;
}

/* Before step i of count, asked every so many steps. 1: the caller cancels. */
static inline int cohsm__cancelled(const cohsm__part *p, size_t i, size_t count, size_t every)
{
    return p->progress && i % every == 0 && cohsm__part_tell(p, (float)((double)i / (double)count)) != 0;
}

/* <<< shared */

/* 64-bit x86 with AVX2 and BMI2, asked for at run time. */
#if COHSM__X86 && (defined(__x86_64__) || defined(_M_X64))
#define COHSM__SIMD 1
#include <immintrin.h>
#else
#define COHSM__SIMD 0
#endif

/* Around what uses AVX-512: gcc's own avx512fintrin.h leaves unused operands undefined, and warns of it in C++; at -O0
   its macros turn signs. */
#if COHSM__SIMD && defined(__GNUC__) && !defined(__clang__)
#define COHSM__AVX512_BEGIN                                                              \
    _Pragma("GCC diagnostic push") _Pragma("GCC diagnostic ignored \"-Wuninitialized\"") \
    _Pragma("GCC diagnostic ignored \"-Wmaybe-uninitialized\"")                          \
    _Pragma("GCC diagnostic ignored \"-Wsign-conversion\"")
#define COHSM__AVX512_END _Pragma("GCC diagnostic pop")
#else
#define COHSM__AVX512_BEGIN
#define COHSM__AVX512_END
#endif

/* 0 none, 1 AVX2, 2 AVX-512 too */
static int cohsm__simd(void) { return !COHSM__SIMD || !cohsm__cpu_has_avx2() ? 0 : cohsm__cpu_has_avx512() ? 2 : 1; }

/* ---- >>types ---- */

/* The block is 32-bit little-endian words, so that one rule serves memory, file, upload and hosts of either byte order:

     header        COHSM__HEADER_WORDS words, cohsm__header below
     order table   HILBERT only: place in the sequence of each cell, 16 bits each up to 65,536 cells, else 32
     locations     TABLE and LIST only: 4 floats a cell
     lookup        one word for each 65,536 views (a chunk) and pixel: where its directory begins,
                   or COHSM__CONSTANT | depth where all maps of the chunk store the same depth there
     directories   see "lists" below; filled up to a multiple of 16 words from the beginning
     lines         the blocks of all lists, 16 words each, then 4 words of padding so that readers may load ahead */

enum {
    COHSM__MAGIC = 0x4d534344,          /* "DCSM" */
    COHSM__FORMAT = 1,
    COHSM__HEADER_WORDS = 96,
    COHSM__PADDING = 4,
    COHSM__BLOCK_WORDS = 16,            /* a block of a list is one cache line */
    COHSM__CHUNK_BITS = 16,
    COHSM__DOP_AXES = 13,
    COHSM__OPEN = 65534,                /* depth of the sphere's far side; hits are at most COHSM__HIT_MAX */
    COHSM__HIT_MAX = 65533,
    COHSM__INFINITE = 65535
};
#define COHSM__CONSTANT 0x80000000u
#define COHSM__CHUNK (1u << COHSM__CHUNK_BITS)

typedef struct cohsm__header {          /* 32-bit fields only */
    uint32_t magic, format, words, crc; /* crc of everything after this field */
    uint32_t domain, layers, order, frame;
    uint32_t side[3], map_count, view_count, map_size, depth_bits, dimensions;
    uint32_t positional, self_only, pixel_begin, pixel_end;
    uint32_t order_words, location_words, lookup_words, directory_words, line_words;
    uint32_t segments_low, segments_high;
    float    center[3], radius, depth_far, open_thickness;
    float    origin[3], u[3], v[3], w[3];
    float    dop[2 * COHSM__DOP_AXES];  /* least and greatest extent along each axis of cohsm__dop_axis */
    uint32_t reserved[COHSM__HEADER_WORDS - 71];
} cohsm__header;

typedef char cohsm__header_size[sizeof(cohsm__header) == 4 * COHSM__HEADER_WORDS ? 1 : -1];

struct cohsm_maps {
    cohsm__allocator  allocator;
    void             *memory;           /* what the allocator gave */
    uint32_t         *words;            /* the block, 64-byte aligned in it so that its lines are cache lines */
    cohsm__header     head;
    const uint32_t   *order, *lookup, *directories, *lines;
    const float      *locations;
    uint32_t          range;            /* pixel_end - pixel_begin */
    float            *angles;           /* LATLONG: cos, sin of each column, then of each row */
    float             dop[2 * COHSM__DOP_AXES]; /* in radii about the centre */
    uint16_t          depth_of[512];    /* stored grid value -> 16-bit depth */
    int               simd;             /* cohsm__simd */
};

typedef struct cohsm__parallel { cohsm_parallel_for run; void *user; } cohsm__parallel;

static void cohsm__run(const cohsm__parallel *p, size_t count, cohsm_task task, void *context)
{
    size_t i;
    if (p->run) p->run(p->user, count, task, context);
    else
        for (i = 0; i < count; i++) task(context, i);
}

/* Allocation with a count of what is asked for at once, for cohsm_stats.peak_bytes. */
typedef struct cohsm__heap { cohsm__allocator allocator; size_t used, peak; } cohsm__heap;

static void *cohsm__take(cohsm__heap *h, size_t count, size_t size)
{
    void *p = cohsm__alloc_array(&h->allocator, count, size);
    if (p) {
        h->used += count * size;
        if (h->used > h->peak) h->peak = h->used;
    }
    return p;
}

static void cohsm__give(cohsm__heap *h, void *p, size_t count, size_t size)
{
    if (!p) return;
    h->used -= count * size;
    cohsm__free(&h->allocator, p);
}

/* A progress callback itself, whose user is a part. */
static int cohsm__part_progress(void *user, float fraction)
{
    return cohsm__part_tell((const cohsm__part *)user, fraction);
}

/* What calls that build nothing take from a desc; 0: its allocator is half. */
static int cohsm__services_of(const cohsm_desc *desc, cohsm__allocator *a, cohsm__part *part)
{
    cohsm_desc none;

    if (!desc) {
        memset(&none, 0, sizeof none);
        desc = &none;
    }
    if (!cohsm__allocator_valid(desc->allocator.alloc_fn, desc->allocator.free_fn)) return 0;
    *a = cohsm__allocator_make(desc->allocator.alloc_fn, desc->allocator.free_fn, desc->allocator.user);
    part->progress = desc->progress;
    part->user = desc->progress_user;
    part->from = 0.0f;
    part->to = 1.0f;
    return 1;
}

static uint32_t cohsm__min_u32(uint32_t a, uint32_t b) { return a < b ? a : b; }
static uint32_t cohsm__max_u32(uint32_t a, uint32_t b) { return a > b ? a : b; }

/* ---- >>order: from cells to places in the sequence ---- */

typedef struct cohsm__walk { uint32_t *out, count, width; } cohsm__walk;

static int cohsm__half(int v) { return v >= 0 ? v / 2 : -((1 - v) / 2); }   /* rounds down */
static int cohsm__sign(int v) { return v > 0 ? 1 : v < 0 ? -1 : 0; }

/* A Hilbert-like curve through a rectangle of any size: starts at (x, y) and covers the cells spanned by the vectors a
   (the way it ends up) and b. Long rectangles are cut in two along a; others in three, as Hilbert's square is in four
   with the middle two joined. Halves are made even where possible, which leaves at most one diagonal step. */
static void cohsm__hilbert_walk(cohsm__walk *walk, int x, int y, int ax, int ay, int bx, int by)
{
    int w = abs(ax + ay), h = abs(bx + by), i;
    int dax = cohsm__sign(ax), day = cohsm__sign(ay), dbx = cohsm__sign(bx), dby = cohsm__sign(by);
    int ax2 = cohsm__half(ax), ay2 = cohsm__half(ay), bx2 = cohsm__half(bx), by2 = cohsm__half(by);

    if (h == 1 || w == 1) {
        for (i = 0; i < (h == 1 ? w : h); i++) {
            walk->out[walk->count++] = (uint32_t)x + (uint32_t)y * walk->width;
            x += h == 1 ? dax : dbx;
            y += h == 1 ? day : dby;
        }
        return;
    }
    if (2 * w > 3 * h) {
        if (abs(ax2 + ay2) % 2 && w > 2) {
            ax2 += dax;
            ay2 += day;
        }
        cohsm__hilbert_walk(walk, x, y, ax2, ay2, bx, by);
        cohsm__hilbert_walk(walk, x + ax2, y + ay2, ax - ax2, ay - ay2, bx, by);
        return;
    }
    if (abs(bx2 + by2) % 2 && h > 2) {
        bx2 += dbx;
        by2 += dby;
    }
    cohsm__hilbert_walk(walk, x, y, bx2, by2, ax2, ay2);
    cohsm__hilbert_walk(walk, x + bx2, y + by2, ax, ay, bx - bx2, by - by2);
    cohsm__hilbert_walk(walk, x + (ax - dax) + (bx2 - dbx), y + (ay - day) + (by2 - dby), -bx2, -by2, -(ax - ax2),
                        -(ay - ay2));
}

/* cells[i] = the cell at place i. Zig-zag in any size, and Hilbert in 1 and 2 dimensions; in 3 dimensions Hilbert's
   cube for powers of two, else layers of the 2-D curve, every other one backwards. */
static void cohsm__order_cells(uint32_t *cells, const uint32_t *side, cohsm_order order)
{
    uint32_t n0 = side[0], n1 = side[1], n2 = side[2], n = n0 * n1 * n2, i, x, y, z, bits, c[3];
    cohsm__walk walk;

    if (order == COHSM_ORDER_HILBERT && n2 > 1 && n0 == n1 && n1 == n2 && (n0 & (n0 - 1u)) == 0) {
        for (bits = 0; 1u << bits < n0; bits++) {}
        for (i = 0; i < n; i++) {
            cohsm__hilbert_cell(i, bits, 3, c);
            cells[i] = c[0] + n0 * (c[1] + n1 * c[2]);
        }
        return;
    }
    if (order == COHSM_ORDER_HILBERT) {
        walk.out = cells;
        walk.count = 0;
        walk.width = n0;
        if (n0 >= n1) cohsm__hilbert_walk(&walk, 0, 0, (int)n0, 0, 0, (int)n1);
        else cohsm__hilbert_walk(&walk, 0, 0, 0, (int)n1, (int)n0, 0);
        for (z = 1; z < n2; z++)
            for (i = 0; i < n0 * n1; i++) cells[z * n0 * n1 + i] = cells[z * n0 * n1 - 1u - i] + n0 * n1;
        return;
    }
    for (i = 0; i < n; i++) {
        if (order == COHSM_ORDER_ZIGZAG_THETA) {
            y = i % n1;
            x = i / n1 % n0;
            z = i / (n0 * n1);
            if ((i / n1) & 1u) y = n1 - 1u - y;
            if (z & 1u) x = n0 - 1u - x;
        } else {
            x = i % n0;
            y = i / n0 % n1;
            z = i / (n0 * n1);
            if (order == COHSM_ORDER_ZIGZAG && (i / n0) & 1u) x = n0 - 1u - x;
            if (order == COHSM_ORDER_ZIGZAG && z & 1u) y = n1 - 1u - y;
        }
        cells[i] = x + n0 * (y + n1 * z);
    }
}

/* ---- >>domain: D, cells and frames ---- */

static uint32_t cohsm__dimensions(cohsm_domain_kind kind, const uint32_t *side)
{
    switch (kind) {
    case COHSM_DOMAIN_LINE: return 1;
    case COHSM_DOMAIN_VOLUME: return 3;
    case COHSM_DOMAIN_LIST: return 0;
    case COHSM_DOMAIN_TABLE: return side[2] > 1 ? 3 : side[1] > 1 ? 2 : 1;
    default: return 2;
    }
}

static int cohsm__has_table(uint32_t kind) { return kind == COHSM_DOMAIN_TABLE || kind == COHSM_DOMAIN_LIST; }

static cohsm__v3 cohsm__affine(const cohsm__header *h, float s, float t, float r)
{
    cohsm__v3 p = cohsm__v3_load(h->origin);
    p = cohsm__v3_madd(p, cohsm__v3_load(h->u), s);
    p = cohsm__v3_madd(p, cohsm__v3_load(h->v), t);
    return cohsm__v3_madd(p, cohsm__v3_load(h->w), r);
}

/* Shirley and Chiu's concentric map of the square to the disc, area-preserving. */
static void cohsm__concentric(float s, float t, float *x, float *y)
{
    float a = 2.0f * s - 1.0f, b = 2.0f * t - 1.0f, r, phi, sine, cosine;
    if (fabsf(a) > fabsf(b)) {
        r = a;
        phi = 0.785398163f * (b / a);
    } else {
        r = b;
        phi = b == 0.0f ? 0.0f : 1.57079633f - 0.785398163f * (a / b);
    }
    cohsm__sincos(phi, &sine, &cosine);
    *x = r * cosine;
    *y = r * sine;
}

/* The analytic D of every kind but TABLE and LIST. */
static cohsm__v3 cohsm__map_parameter(const cohsm__header *h, float s, float t, float r)
{
    float sine, cosine, ring, x, y;
    cohsm__v3 p;

    switch (h->domain) {
    case COHSM_DOMAIN_OCTAHEDRAL: return cohsm__octa_direction(s, t);
    case COHSM_DOMAIN_DISC:
        cohsm__concentric(s, t, &x, &y);
        return cohsm__affine(h, x, y, 0.0f);
    case COHSM_DOMAIN_SPHERE:
        cohsm__sincos((s - 0.5f) * 6.28318531f, &sine, &cosine);
        y = 1.0f - 2.0f * t;
        ring = sqrtf(y >= 1.0f || y <= -1.0f ? 0.0f : 1.0f - y * y);
        p = cohsm__v3_make(ring * cosine, y, ring * sine);
        return cohsm__v3_madd(cohsm__v3_load(h->origin), p, cohsm__v3_length(cohsm__v3_load(h->u)));
    case COHSM_DOMAIN_LATLONG:
        cohsm__sincos((s - 0.5f) * 6.28318531f, &sine, &cosine);
        cohsm__sincos(t * 3.14159265f, &ring, &y);
        return cohsm__v3_make(ring * cosine, y, ring * sine);
    default: return cohsm__affine(h, s, t, r);
    }
}

static void cohsm__cell_split(const uint32_t *side, uint32_t cell, uint32_t *c)
{
    c[0] = cell % side[0];
    c[1] = cell / side[0] % side[1];
    c[2] = cell / (side[0] * side[1]);
}

static cohsm__v3 cohsm__cell_location(const cohsm__header *h, const float *table, uint32_t cell)
{
    uint32_t c[3];
    if (cohsm__has_table(h->domain)) return cohsm__v3_load(table + 4 * (size_t)cell);
    cohsm__cell_split(h->side, cell, c);
    return cohsm__map_parameter(h, ((float)c[0] + 0.5f) / (float)h->side[0], ((float)c[1] + 0.5f) / (float)h->side[1],
                                ((float)c[2] + 0.5f) / (float)h->side[2]);
}

typedef struct cohsm__frame { cohsm__v3 right, up, back; } cohsm__frame;  /* back points to the light */

static cohsm__frame cohsm__frame_of(uint32_t kind, cohsm__v3 d)
{
    cohsm__frame f;
    float s, a, h;

    f.back = d;
    if (kind == COHSM_FRAME_POLAR) {
        h = sqrtf(d.x * d.x + d.z * d.z);
        f.right = h > 1e-6f ? cohsm__v3_make(-d.z / h, 0.0f, d.x / h) : cohsm__v3_make(0.0f, 0.0f, 1.0f);
        f.up = cohsm__v3_cross(f.right, d);
        return f;
    }
    s = kind == COHSM_FRAME_MINIMAL || d.y >= 0.0f ? 1.0f : -1.0f;
    if (s + d.y > -1e-6f && s + d.y < 1e-6f) {       /* MINIMAL at -Y: any frame is as short a way */
        f.right = cohsm__v3_make(1.0f, 0.0f, 0.0f);
        f.up = cohsm__v3_make(0.0f, 0.0f, 1.0f);
        return f;
    }
    a = -1.0f / (s + d.y);
    f.right = cohsm__v3_make(1.0f + s * d.x * d.x * a, -s * d.x, s * d.x * d.z * a);
    f.up = cohsm__v3_make(d.x * d.z * a, -d.z, s + d.z * d.z * a);
    return f;
}

/* LATLONG with the polar frame, from its four angles: the pole has a right direction too. */
static cohsm__frame cohsm__frame_latlong(float cos_phi, float sin_phi, float cos_theta, float sin_theta)
{
    cohsm__frame f;
    f.right = cohsm__v3_make(-sin_phi, 0.0f, cos_phi);
    f.up = cohsm__v3_make(-cos_theta * cos_phi, sin_theta, -cos_theta * sin_phi);
    f.back = cohsm__v3_make(sin_theta * cos_phi, cos_theta, sin_theta * sin_phi);
    return f;
}

/* angles = cos, sin of each column's azimuth, then of each row's polar angle; 2 (side[0] + side[1]) floats */
static void cohsm__latlong_angles(const uint32_t *side, float *angles)
{
    uint32_t i;
    for (i = 0; i < side[0]; i++, angles += 2)
        cohsm__sincos((((float)i + 0.5f) / (float)side[0] - 0.5f) * 6.28318531f, angles + 1, angles);
    for (i = 0; i < side[1]; i++, angles += 2)
        cohsm__sincos(((float)i + 0.5f) / (float)side[1] * 3.14159265f, angles + 1, angles);
}

static cohsm__frame cohsm__cell_frame(const cohsm__header *h, const float *table, const float *angles, uint32_t cell)
{
    const float *column, *row;
    cohsm__frame f;
    if (h->domain != COHSM_DOMAIN_LATLONG) return cohsm__frame_of(h->frame, cohsm__cell_location(h, table, cell));
    column = angles + 2 * (cell % h->side[0]);
    row = angles + 2 * h->side[0] + 2 * (cell / h->side[0]);
    f = cohsm__frame_latlong(column[0], column[1], row[0], row[1]);
    return h->frame == COHSM_FRAME_POLAR ? f : cohsm__frame_of(h->frame, f.back);
}

/* Faces of a cube: 2 axis + (1 where it looks along the negative axis). Pixel x runs along the next axis, y along the
   one after, in every face: neighbours along an edge need no rotation, and the mirroring harms nothing. */
static void cohsm__face_coordinates(uint32_t face, cohsm__v3 q, float *x, float *y, float *w)
{
    float c[3];
    c[0] = q.x;
    c[1] = q.y;
    c[2] = q.z;
    *w = face & 1u ? -c[face >> 1] : c[face >> 1];
    *x = c[((face >> 1) + 1u) % 3u];
    *y = c[((face >> 1) + 2u) % 3u];
}

static uint32_t cohsm__face_of(cohsm__v3 q)
{
    float x = fabsf(q.x), y = fabsf(q.y), z = fabsf(q.z);
    if (x >= y && x >= z) return q.x < 0.0f ? 1u : 0u;
    if (y >= z) return q.y < 0.0f ? 3u : 2u;
    return q.z < 0.0f ? 5u : 4u;
}

/* ---- >>raster: the first layers of a triangle mesh ---- */

/* Samples lie at pixel centres; corners are rounded to 1/256 pixel, so that triangles of a shared edge see the same
   corners, and the fill rule gives every sample of that edge to one of them: no sample is counted twice or missed.
   Every bit of the result follows from + - * / and integers; the order of triangles does not matter. */

enum { COHSM__LANES = 8, COHSM__SUBPIXEL = 256 };

typedef struct cohsm__soup {            /* corners in units of the bounding sphere, groups of 8 triangles */
    float   *v;                         /* per group x0[8] y0[8] z0[8] x1[8] ... z2[8]; the last group is filled up
                                           with triangles of no area */
    float   *bounds;                    /* boxes of each 2 groups, neighbours in space, as cohsm__sees8 wants them; then
                                           of each 8 such clusters */
    uint32_t groups, triangles;
} cohsm__soup;

typedef struct cohsm__camera {
    int          perspective;
    cohsm__frame frame;                 /* orthographic */
    cohsm__v3    eye;                   /* perspective, in units of the bounding sphere about its centre */
    uint32_t     face;
    float        depth_scale;           /* perspective: w (in radii) to depth 0..1 */
} cohsm__camera;

typedef struct cohsm__target {
    uint16_t *z;                        /* keep values a pixel, nearest first; COHSM__INFINITE = no hit */
    uint32_t  keep;                     /* 2 or 4 (the fourth is unused) */
    int       size, row_begin, row_end; /* M, and the rows that are wanted */
} cohsm__target;

static void cohsm__insert(uint16_t *z, uint32_t keep, uint16_t depth)
{
    uint16_t t;
    if (keep == 2) {
        if (depth >= z[1]) return;
        if (depth < z[0]) {
            z[1] = z[0];
            z[0] = depth;
        } else z[1] = depth;
        return;
    }
    if (depth >= z[2]) return;
    z[2] = depth;
    if (z[2] < z[1]) {
        t = z[1];
        z[1] = z[2];
        z[2] = t;
    }
    if (z[1] < z[0]) {
        t = z[0];
        z[0] = z[1];
        z[1] = t;
    }
}

static uint16_t cohsm__depth16(float z)
{
    float s = z * (float)COHSM__HIT_MAX;
    return (uint16_t)(s > 0.0f ? s < (float)COHSM__HIT_MAX ? (int)s : COHSM__HIT_MAX : 0);
}

/* A corner on the image plane: fixed-point position, and depth or 1/w. */
typedef struct cohsm__corner { int32_t x, y; float z; } cohsm__corner;

/* The edge from a to b takes the samples exactly on it or leaves them to the neighbour, who sees it from b to a. */
static int cohsm__edge_loses(const cohsm__corner *a, const cohsm__corner *b)
{
    return !(b->y > a->y || (b->y == a->y && b->x > a->x));
}

static int64_t cohsm__edge(const cohsm__corner *a, const cohsm__corner *b, int32_t x, int32_t y)
{
    return (int64_t)(b->x - a->x) * (y - a->y) - (int64_t)(b->y - a->y) * (x - a->x);
}

static void cohsm__fill(const cohsm__target *t, const cohsm__camera *cam, const cohsm__corner *p0,
                        const cohsm__corner *p1, const cohsm__corner *p2)
{
    int64_t area = (int64_t)(p1->x - p0->x) * (p2->y - p0->y) - (int64_t)(p1->y - p0->y) * (p2->x - p0->x);
    int64_t w0, w1, w2, s0, s1, s2;
    int e0, e1, e2;
    int32_t lx, hx, ly, hy, x0, x1, y0, y1, x, y;
    const cohsm__corner *swap;
    float scale, z;

    if (area == 0) return;
    if (area < 0) {
        swap = p1;
        p1 = p2;
        p2 = swap;
        area = -area;
    }
    lx = p0->x < p1->x ? p0->x : p1->x;
    hx = p0->x > p1->x ? p0->x : p1->x;
    ly = p0->y < p1->y ? p0->y : p1->y;
    hy = p0->y > p1->y ? p0->y : p1->y;
    if (p2->x < lx) lx = p2->x;
    if (p2->x > hx) hx = p2->x;
    if (p2->y < ly) ly = p2->y;
    if (p2->y > hy) hy = p2->y;
    /* the samples x * 256 + 128 within lx..hx; clamped first, since shifts of negative numbers are not portable */
    x0 = lx <= 128 ? 0 : (lx + 127) >> 8;
    y0 = ly <= 128 + 256 * t->row_begin ? t->row_begin : (ly + 127) >> 8;
    x1 = hx < 128 ? -1 : (hx - 128) >> 8;
    y1 = hy < 128 ? -1 : (hy - 128) >> 8;
    if (x1 >= t->size) x1 = t->size - 1;
    if (y1 >= t->row_end) y1 = t->row_end - 1;
    if (x0 > x1 || y0 > y1) return;

    s0 = cohsm__edge(p1, p2, x0 * 256 + 128, y0 * 256 + 128);
    s1 = cohsm__edge(p2, p0, x0 * 256 + 128, y0 * 256 + 128);
    s2 = cohsm__edge(p0, p1, x0 * 256 + 128, y0 * 256 + 128);
    e0 = cohsm__edge_loses(p1, p2);
    e1 = cohsm__edge_loses(p2, p0);
    e2 = cohsm__edge_loses(p0, p1);
    scale = 1.0f / (float)area;
    for (y = y0; y <= y1; y++) {
        w0 = s0;
        w1 = s1;
        w2 = s2;
        for (x = x0; x <= x1; x++) {
            if (w0 >= e0 && w1 >= e1 && w2 >= e2) {
                z = ((float)w0 * p0->z + (float)w1 * p1->z + (float)w2 * p2->z) * scale;
                if (cam->perspective) z = cam->depth_scale / z;
                cohsm__insert(t->z + (size_t)t->keep * (size_t)(y * t->size + x), t->keep, cohsm__depth16(z));
            }
            w0 -= (int64_t)(p2->y - p1->y) * 256;
            w1 -= (int64_t)(p0->y - p2->y) * 256;
            w2 -= (int64_t)(p1->y - p0->y) * 256;
        }
        s0 += (int64_t)(p2->x - p1->x) * 256;
        s1 += (int64_t)(p0->x - p2->x) * 256;
        s2 += (int64_t)(p1->x - p0->x) * 256;
    }
}

/* One group, orthographic. Most triangles of a fine mesh cover no sample, so their boxes are tested first. */
static void cohsm__raster_group(const cohsm__target *t, const cohsm__camera *cam, const float *v)
{
    int32_t px[3][COHSM__LANES], py[3][COHSM__LANES];
    float scale = (float)(t->size * (COHSM__SUBPIXEL / 2)), offset = scale + 0.5f;
    cohsm__v3 r = cohsm__v3_scale(cam->frame.right, scale), u = cohsm__v3_scale(cam->frame.up, scale);
    cohsm__v3 b = cam->frame.back;
    cohsm__corner corner[3];
    int i, k;

    for (k = 0; k < 3; k++, v += 3 * COHSM__LANES)
        for (i = 0; i < COHSM__LANES; i++) {
            px[k][i] = (int32_t)(v[i] * r.x + v[8 + i] * r.y + v[16 + i] * r.z + offset);
            py[k][i] = (int32_t)(v[i] * u.x + v[8 + i] * u.y + v[16 + i] * u.z + offset);
        }
    v -= 9 * COHSM__LANES;
    for (i = 0; i < COHSM__LANES; i++) {
        int32_t lx = px[0][i] < px[1][i] ? px[0][i] : px[1][i], hx = px[0][i] > px[1][i] ? px[0][i] : px[1][i];
        int32_t ly = py[0][i] < py[1][i] ? py[0][i] : py[1][i], hy = py[0][i] > py[1][i] ? py[0][i] : py[1][i];
        lx = lx < px[2][i] ? lx : px[2][i];
        hx = hx > px[2][i] ? hx : px[2][i];
        ly = ly < py[2][i] ? ly : py[2][i];
        hy = hy > py[2][i] ? hy : py[2][i];
        if ((lx + 127) >> 8 > (hx - 128) >> 8 || (ly + 127) >> 8 > (hy - 128) >> 8) continue;
        for (k = 0; k < 3; k++) {
            const float *c = v + 3 * COHSM__LANES * k + i;
            corner[k].x = px[k][i];
            corner[k].y = py[k][i];
            corner[k].z = 0.5f - 0.5f * (c[0] * b.x + c[8] * b.y + c[16] * b.z);
        }
        cohsm__fill(t, cam, corner, corner + 1, corner + 2);
    }
}

/* Two groups are a cluster. */
static uint32_t cohsm__clusters(const cohsm__soup *soup) { return soup->groups / 2u; }

static const float *cohsm__group(const cohsm__soup *soup, uint32_t cluster, uint32_t i)
{
    return soup->v + (2 * (size_t)cluster + i) * 9 * COHSM__LANES;
}

/* 8 boxes at a time: of clusters, and of 8 clusters each. */
static uint32_t cohsm__eights(uint32_t count) { return (count + 7u) / 8u; }
static size_t cohsm__bound_count(const cohsm__soup *soup)
{
    return (size_t)cohsm__eights(cohsm__clusters(soup)) + cohsm__eights(cohsm__eights(cohsm__clusters(soup)));
}
static float *cohsm__wide_bounds(const cohsm__soup *soup)
{
    return soup->bounds + 48 * (size_t)cohsm__eights(cohsm__clusters(soup));
}

/* Which of 8 clusters may cover samples of the wanted rows, one bit each. Rounding moves corners by less than a
   hundredth of a pixel. box: middles' x of all eight, y, z, then half sides. */
static unsigned cohsm__sees8(const cohsm__target *t, const cohsm__camera *cam, const float *box)
{
    cohsm__v3 u = cam->frame.up;
    float half = 0.5f * (float)t->size, begin = (float)t->row_begin + 0.5f, end = (float)t->row_end - 0.5f, y, e;
    int seen[8], i;
    unsigned mask = 0;

    for (i = 0; i < 8; i++) {
        y = (box[i] * u.x + box[8 + i] * u.y + box[16 + i] * u.z + 1.0f) * half;
        e = (fabsf(u.x) * box[24 + i] + fabsf(u.y) * box[32 + i] + fabsf(u.z) * box[40 + i]) * half + 0.01f;
        seen[i] = (y + e >= begin) & (y - e <= end);
    }
    for (i = 0; i < 8; i++) mask |= (unsigned)seen[i] << i;
    return mask;
}

static unsigned cohsm__face_sees8(const cohsm__target *t, const cohsm__camera *cam, const float *box)
{
    float half = 0.5f * (float)t->size, low = ((float)t->row_begin + 0.49f) / half - 1.0f;
    float high = ((float)t->row_end - 0.49f) / half - 1.0f, x, y, w, ex, ey, ew;
    unsigned mask = 0;
    int i;

    for (i = 0; i < 8; i++) {
        cohsm__v3 c = cohsm__v3_make(box[i], box[8 + i], box[16 + i]);
        cohsm__face_coordinates(cam->face, cohsm__v3_sub(c, cam->eye), &x, &y, &w);
        cohsm__face_coordinates(cam->face, cohsm__v3_make(box[24 + i], box[32 + i], box[40 + i]), &ex, &ey, &ew);
        ex = fabsf(ex);
        ey = fabsf(ey);
        ew = fabsf(ew);
        if (w + ew > 0.0f && fabsf(x) - w <= ex + ew && y - low * w >= -ey - fabsf(low) * ew &&
            y - high * w <= ey + fabsf(high) * ew)
            mask |= 1u << i;
    }
    return mask;
}

/* Triangles whose boxes hold samples wait here until there are many; then whole eights or sixteens are drawn. One in
   five does on a fine mesh, and no branch predictor knows which: a branch after each group costs more than its
   set-up. */
enum { COHSM__MANY = 128, COHSM__QUEUE = COHSM__MANY + 32 };
typedef struct cohsm__queue {
    int32_t  x[3][COHSM__QUEUE], y[3][COHSM__QUEUE];
    float    z[3][COHSM__QUEUE];
    uint32_t count;
} cohsm__queue;

/* Those in sight of COHSM__STRETCH clusters that are neighbours; lists are written eight at a time. */
enum { COHSM__STRETCH = 512 };
typedef struct cohsm__sight { uint32_t cluster[COHSM__STRETCH + 8], count; } cohsm__sight;

/* Of 8 bits those that stand for one of count. */
static unsigned cohsm__first8(uint32_t count) { return count < 8 ? (1u << count) - 1u : 255u; }

#if COHSM__SIMD
/* Short loops over vectors, which must stay in registers: gcc's -O2 does not unroll them by itself. */
#if defined(__clang__)
#define COHSM__UNROLL _Pragma("clang loop unroll(full)")
#elif defined(__GNUC__)
#define COHSM__UNROLL _Pragma("GCC unroll 3")
#else
#define COHSM__UNROLL
#endif

/* The same for 8 triangles at a time, equal to the last bit. Nearly all boxes of a fine mesh hold no sample or a few:
   those go through the samples of their boxes together; triangles with larger ones take cohsm__fill. */
COHSM__TARGET_AVX2 static __m256i cohsm__edge8(__m256i ax, __m256i ay, __m256i bx, __m256i by)
{
    return _mm256_sub_epi32(_mm256_mullo_epi32(ax, by), _mm256_mullo_epi32(bx, ay));
}

/* -1 where the edge from a to b loses the samples exactly on it */
COHSM__TARGET_AVX2 static __m256i cohsm__edge_loses8(__m256i ax, __m256i ay, __m256i bx, __m256i by)
{
    __m256i wins = _mm256_or_si256(_mm256_cmpgt_epi32(by, ay),
                                   _mm256_and_si256(_mm256_cmpeq_epi32(by, ay), _mm256_cmpgt_epi32(bx, ax)));
    return _mm256_xor_si256(wins, _mm256_set1_epi32(-1));
}

COHSM__TARGET_AVX2 static __m256 cohsm__dot8(const float *v, cohsm__v3 a)
{
    __m256 xy = _mm256_add_ps(_mm256_mul_ps(_mm256_loadu_ps(v), _mm256_set1_ps(a.x)),
                              _mm256_mul_ps(_mm256_loadu_ps(v + 8), _mm256_set1_ps(a.y)));
    return _mm256_add_ps(xy, _mm256_mul_ps(_mm256_loadu_ps(v + 16), _mm256_set1_ps(a.z)));
}

typedef struct cohsm__corners8 { __m256i x[3], y[3]; __m256 z[3]; } cohsm__corners8;

/* Samples (x, y) of 8 triangles, where wanted. Coordinates relative to the sample stay below 2^11: 32 bits
   are enough. */
COHSM__TARGET_AVX2 static void cohsm__sample8(const cohsm__target *t, const cohsm__corners8 *c, __m256i x, __m256i y,
                                              __m256i wanted)
{
    __m256i sx = _mm256_add_epi32(_mm256_slli_epi32(x, 8), _mm256_set1_epi32(128));
    __m256i sy = _mm256_add_epi32(_mm256_slli_epi32(y, 8), _mm256_set1_epi32(128));
    __m256i x0 = _mm256_sub_epi32(c->x[0], sx), y0 = _mm256_sub_epi32(c->y[0], sy);
    __m256i x1 = _mm256_sub_epi32(c->x[1], sx), y1 = _mm256_sub_epi32(c->y[1], sy);
    __m256i x2 = _mm256_sub_epi32(c->x[2], sx), y2 = _mm256_sub_epi32(c->y[2], sy);
    __m256i w0 = cohsm__edge8(x1, y1, x2, y2), w1 = cohsm__edge8(x2, y2, x0, y0), w2 = cohsm__edge8(x0, y0, x1, y1);
    __m256i area = _mm256_add_epi32(_mm256_add_epi32(w0, w1), w2), zero = _mm256_setzero_si256();
    __m256i flip = _mm256_cmpgt_epi32(zero, area), in0, in1, in2;
    __m256 za, zb, wa, wb, z, flipped = _mm256_castsi256_ps(flip);
    uint32_t pixel[8], depth[8];
    unsigned mask;

    /* seen from behind: all signs turn, and an edge run the other way loses where it would win */
    in0 = _mm256_xor_si256(cohsm__edge_loses8(x1, y1, x2, y2), flip);
    in1 = _mm256_xor_si256(cohsm__edge_loses8(x2, y2, x0, y0), flip);
    in2 = _mm256_xor_si256(cohsm__edge_loses8(x0, y0, x1, y1), flip);
    w0 = _mm256_sub_epi32(_mm256_xor_si256(w0, flip), flip);
    w1 = _mm256_sub_epi32(_mm256_xor_si256(w1, flip), flip);
    w2 = _mm256_sub_epi32(_mm256_xor_si256(w2, flip), flip);
    area = _mm256_sub_epi32(_mm256_xor_si256(area, flip), flip);
    wanted = _mm256_and_si256(wanted, _mm256_cmpgt_epi32(area, zero));
    wanted = _mm256_and_si256(wanted, _mm256_cmpgt_epi32(w0, _mm256_xor_si256(in0, _mm256_set1_epi32(-1))));
    wanted = _mm256_and_si256(wanted, _mm256_cmpgt_epi32(w1, _mm256_xor_si256(in1, _mm256_set1_epi32(-1))));
    wanted = _mm256_and_si256(wanted, _mm256_cmpgt_epi32(w2, _mm256_xor_si256(in2, _mm256_set1_epi32(-1))));
    mask = (unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(wanted));
    if (!mask) return;
    wa = _mm256_blendv_ps(_mm256_cvtepi32_ps(w1), _mm256_cvtepi32_ps(w2), flipped);
    wb = _mm256_blendv_ps(_mm256_cvtepi32_ps(w2), _mm256_cvtepi32_ps(w1), flipped);
    za = _mm256_blendv_ps(c->z[1], c->z[2], flipped);
    zb = _mm256_blendv_ps(c->z[2], c->z[1], flipped);
    z = _mm256_add_ps(_mm256_mul_ps(_mm256_cvtepi32_ps(w0), c->z[0]), _mm256_mul_ps(wa, za));
    z = _mm256_add_ps(z, _mm256_mul_ps(wb, zb));
    z = _mm256_mul_ps(z, _mm256_div_ps(_mm256_set1_ps(1.0f), _mm256_cvtepi32_ps(area)));
    z = _mm256_mul_ps(z, _mm256_set1_ps((float)COHSM__HIT_MAX));
    z = _mm256_min_ps(_mm256_max_ps(z, _mm256_setzero_ps()), _mm256_set1_ps((float)COHSM__HIT_MAX));
    _mm256_storeu_si256((__m256i *)(void *)depth, _mm256_cvttps_epi32(z));
    _mm256_storeu_si256((__m256i *)(void *)pixel,
                        _mm256_add_epi32(_mm256_mullo_epi32(y, _mm256_set1_epi32(t->size)), x));
    for (; mask; mask &= mask - 1u) {
        unsigned lane = _tzcnt_u32(mask);
        cohsm__insert(t->z + (size_t)t->keep * pixel[lane], t->keep, (uint16_t)depth[lane]);
    }
}

COHSM__TARGET_AVX2 static void cohsm__fill_lanes(const cohsm__target *t, const cohsm__camera *cam,
                                                 const cohsm__corners8 *c, unsigned lanes)
{
    int32_t x[3][8], y[3][8];
    float z[3][8];
    cohsm__corner p[3];
    int k;

    for (k = 0; k < 3; k++) {
        _mm256_storeu_si256((__m256i *)(void *)x[k], c->x[k]);
        _mm256_storeu_si256((__m256i *)(void *)y[k], c->y[k]);
        _mm256_storeu_ps(z[k], c->z[k]);
    }
    for (; lanes; lanes &= lanes - 1u) {
        int lane = (int)_tzcnt_u32(lanes);
        for (k = 0; k < 3; k++) {
            p[k].x = x[k][lane];
            p[k].y = y[k][lane];
            p[k].z = z[k][lane];
        }
        cohsm__fill(t, cam, p, p + 1, p + 2);
    }
}

/* The samples low..high between the least and the greatest of three coordinates, within begin..end - 1. */
COHSM__TARGET_AVX2 static inline void cohsm__span8(const __m256i *c, int begin, int end, __m256i *low, __m256i *high)
{
    __m256i l = _mm256_min_epi32(_mm256_min_epi32(c[0], c[1]), c[2]);
    __m256i h = _mm256_max_epi32(_mm256_max_epi32(c[0], c[1]), c[2]);
    l = _mm256_srai_epi32(_mm256_add_epi32(l, _mm256_set1_epi32(127)), 8);
    h = _mm256_srai_epi32(_mm256_sub_epi32(h, _mm256_set1_epi32(128)), 8);
    *low = _mm256_max_epi32(l, _mm256_set1_epi32(begin));
    *high = _mm256_min_epi32(h, _mm256_set1_epi32(end - 1));
}


COHSM__TARGET_AVX2 static void cohsm__raster_queue(const cohsm__target *t, const cohsm__camera *cam,
                                                   const cohsm__queue *q, uint32_t at)
{
    __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), one = _mm256_set1_epi32(1), few = _mm256_set1_epi32(4);
    __m256i wide, none, x, y, row, lx, hx, ly, hy;
    cohsm__corners8 c;
    unsigned large;
    int k;

    COHSM__UNROLL
    for (k = 0; k < 3; k++) {
        c.x[k] = _mm256_loadu_si256((const __m256i *)(const void *)(q->x[k] + at));
        c.y[k] = _mm256_loadu_si256((const __m256i *)(const void *)(q->y[k] + at));
        c.z[k] = _mm256_loadu_ps(q->z[k] + at);
    }
    cohsm__span8(c.x, 0, t->size, &lx, &hx);
    cohsm__span8(c.y, t->row_begin, t->row_end, &ly, &hy);
    none = _mm256_cmpgt_epi32(lane, _mm256_set1_epi32((int)(q->count - at) - 1));
    wide = _mm256_or_si256(_mm256_cmpgt_epi32(_mm256_sub_epi32(hx, lx), few),
                           _mm256_cmpgt_epi32(_mm256_sub_epi32(hy, ly), few));
    wide = _mm256_andnot_si256(none, wide);
    large = (unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(wide));
    if (large) cohsm__fill_lanes(t, cam, &c, large);
    none = _mm256_or_si256(none, wide);
    for (y = ly;; y = _mm256_add_epi32(y, one)) {
        row = _mm256_andnot_si256(_mm256_or_si256(_mm256_cmpgt_epi32(y, hy), none), _mm256_set1_epi32(-1));
        if (_mm256_testz_si256(row, row)) break;
        for (x = lx;; x = _mm256_add_epi32(x, one)) {
            __m256i wanted = _mm256_andnot_si256(_mm256_cmpgt_epi32(x, hx), row);
            if (_mm256_testz_si256(wanted, wanted)) break;
            cohsm__sample8(t, &c, x, y, wanted);
        }
    }
}

/* Which lanes are in mask: they come first. */
COHSM__TARGET_AVX2 static inline __m256i cohsm__lanes8(unsigned mask)
{
    uint64_t bytes = _pext_u64(0x0706050403020100u, _pdep_u64(mask, 0x0101010101010101u) * 255u);
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)bytes));
}

COHSM__TARGET_AVX2 static void cohsm__enqueue8(cohsm__queue *q, const cohsm__corners8 *c, unsigned mask)
{
    __m256i permute = cohsm__lanes8(mask);
    int k;
    COHSM__UNROLL
    for (k = 0; k < 3; k++) {
        _mm256_storeu_si256((__m256i *)(void *)(q->x[k] + q->count), _mm256_permutevar8x32_epi32(c->x[k], permute));
        _mm256_storeu_si256((__m256i *)(void *)(q->y[k] + q->count), _mm256_permutevar8x32_epi32(c->y[k], permute));
        _mm256_storeu_ps(q->z[k] + q->count, _mm256_permutevar8x32_ps(c->z[k], permute));
    }
    q->count += (uint32_t)_mm_popcnt_u32(mask);
}

/* All that are in whole eights, or all; what is left moves to the front. */
COHSM__TARGET_AVX2 static void cohsm__drain8(const cohsm__target *t, const cohsm__camera *cam, cohsm__queue *q, int all)
{
    uint32_t at = 0;
    int k;
    for (; q->count - at >= (all ? 1u : 8u) && q->count > at; at += 8) cohsm__raster_queue(t, cam, q, at);
    if (!at) return;
    q->count -= cohsm__min_u32(q->count, at);
    COHSM__UNROLL
    for (k = 0; k < 3; k++) {
        memcpy(q->x[k], q->x[k] + at, 32);
        memcpy(q->y[k], q->y[k] + at, 32);
        memcpy(q->z[k], q->z[k] + at, 32);
    }
}

COHSM__TARGET_AVX2 static inline unsigned cohsm__sees8_avx2(const cohsm__target *t, cohsm__v3 up, const float *box)
{
    __m256 half = _mm256_set1_ps(0.5f * (float)t->size), above, below, y, e;
    y = _mm256_mul_ps(_mm256_add_ps(cohsm__dot8(box, up), _mm256_set1_ps(1.0f)), half);
    up = cohsm__v3_make(fabsf(up.x), fabsf(up.y), fabsf(up.z));
    e = _mm256_add_ps(_mm256_mul_ps(cohsm__dot8(box + 24, up), half), _mm256_set1_ps(0.01f));
    above = _mm256_cmp_ps(_mm256_add_ps(y, e), _mm256_set1_ps((float)t->row_begin + 0.5f), _CMP_GE_OQ);
    below = _mm256_cmp_ps(_mm256_sub_ps(y, e), _mm256_set1_ps((float)t->row_end - 0.5f), _CMP_LE_OQ);
    return (unsigned)_mm256_movemask_ps(_mm256_and_ps(above, below));
}

/* Numbers from first on whose bits are set, appended to a list of count. */
COHSM__TARGET_AVX2 static inline uint32_t cohsm__append8(uint32_t *list, uint32_t count, unsigned mask, uint32_t first)
{
    _mm256_storeu_si256((__m256i *)(void *)(list + count),
                        _mm256_add_epi32(cohsm__lanes8(mask), _mm256_set1_epi32((int)first)));
    return count + (uint32_t)_mm_popcnt_u32(mask);
}

/* cohsm__find */
COHSM__TARGET_AVX2 static void cohsm__find_avx2(const cohsm__target *t, const cohsm__camera *cam,
                                                const cohsm__soup *soup, uint32_t begin, uint32_t end,
                                                cohsm__sight *sight)
{
    const float *wide = cohsm__wide_bounds(soup);
    uint32_t eight[COHSM__STRETCH / 8 + 8], eights = cohsm__eights(end), count = 0, i;
    cohsm__v3 up = cam->frame.up;
    unsigned mask;

    for (i = begin / 8; i < eights; i += 8) {
        mask = cohsm__sees8_avx2(t, up, wide + 6 * (size_t)i) & cohsm__first8(eights - i);
        count = cohsm__append8(eight, count, mask, i);
    }
    for (i = 0, sight->count = 0; i < count; i++) {
        mask = cohsm__sees8_avx2(t, up, soup->bounds + 48 * (size_t)eight[i]) & cohsm__first8(end - 8 * eight[i]);
        sight->count = cohsm__append8(sight->cluster, sight->count, mask, 8 * eight[i]);
    }
}

COHSM__TARGET_AVX2 static void cohsm__raster_avx2(const cohsm__target *t, const cohsm__camera *cam,
                                                  const cohsm__soup *soup, const cohsm__sight *sight, cohsm__queue *q)
{
    float scale = (float)(t->size * (COHSM__SUBPIXEL / 2)), offset = scale + 0.5f;
    cohsm__v3 r = cohsm__v3_scale(cam->frame.right, scale), u = cohsm__v3_scale(cam->frame.up, scale);
    __m256 offset8 = _mm256_set1_ps(offset), half = _mm256_set1_ps(0.5f);
    __m256i lx, hx, ly, hy, none;
    cohsm__corners8 c;
    uint32_t i;
    int k;

    for (i = 0; i < 2u * sight->count; i++) {
        const float *v = cohsm__group(soup, sight->cluster[i / 2u], i % 2u);
        COHSM__UNROLL
        for (k = 0; k < 3; k++) {
            c.x[k] = _mm256_cvttps_epi32(_mm256_add_ps(cohsm__dot8(v + 24 * k, r), offset8));
            c.y[k] = _mm256_cvttps_epi32(_mm256_add_ps(cohsm__dot8(v + 24 * k, u), offset8));
            c.z[k] = _mm256_sub_ps(half, _mm256_mul_ps(half, cohsm__dot8(v + 24 * k, cam->frame.back)));
        }
        cohsm__span8(c.x, 0, t->size, &lx, &hx);
        cohsm__span8(c.y, t->row_begin, t->row_end, &ly, &hy);
        none = _mm256_or_si256(_mm256_cmpgt_epi32(lx, hx), _mm256_cmpgt_epi32(ly, hy));
        cohsm__enqueue8(q, &c, ~(unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(none)) & 255u);
        if (q->count > COHSM__MANY) cohsm__drain8(t, cam, q, 0);
    }
}

COHSM__AVX512_BEGIN
/* The same for 16, two groups at a time. */
typedef struct cohsm__corners16 { __m512i x[3], y[3]; __m512 z[3]; } cohsm__corners16;

COHSM__TARGET_AVX512 static inline __m512 cohsm__two8(const float *v)
{
    return _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps(v)), _mm256_loadu_ps(v + 9 * COHSM__LANES), 1);
}

COHSM__TARGET_AVX512 static inline __m512 cohsm__dot16(const __m512 *v, cohsm__v3 a)
{
    __m512 xy = _mm512_add_ps(_mm512_mul_ps(v[0], _mm512_set1_ps(a.x)), _mm512_mul_ps(v[1], _mm512_set1_ps(a.y)));
    return _mm512_add_ps(xy, _mm512_mul_ps(v[2], _mm512_set1_ps(a.z)));
}

/* The samples low..high between the least and the greatest of three coordinates, within begin..end - 1. */
COHSM__TARGET_AVX512 static inline void cohsm__span16(const __m512i *c, int begin, int end, __m512i *low, __m512i *high)
{
    __m512i l = _mm512_min_epi32(_mm512_min_epi32(c[0], c[1]), c[2]);
    __m512i h = _mm512_max_epi32(_mm512_max_epi32(c[0], c[1]), c[2]);
    l = _mm512_srai_epi32(_mm512_add_epi32(l, _mm512_set1_epi32(127)), 8);
    h = _mm512_srai_epi32(_mm512_sub_epi32(h, _mm512_set1_epi32(128)), 8);
    *low = _mm512_max_epi32(l, _mm512_set1_epi32(begin));
    *high = _mm512_min_epi32(h, _mm512_set1_epi32(end - 1));
}

/* An edge from a to b: where the sample at the origin is inside, w its double area; a flipped triangle's signs turn. */
COHSM__TARGET_AVX512 static inline __mmask16 cohsm__inside16(__m512i ax, __m512i ay, __m512i bx, __m512i by,
                                                            __mmask16 flip, __m512i *w)
{
    __mmask16 wins = _mm512_cmpgt_epi32_mask(by, ay) |
                     (_mm512_cmpeq_epi32_mask(by, ay) & _mm512_cmpgt_epi32_mask(bx, ax));
    *w = _mm512_mask_sub_epi32(*w, flip, _mm512_setzero_si512(), *w);
    return _mm512_cmpgt_epi32_mask(*w, _mm512_setzero_si512()) |
           (_mm512_cmpeq_epi32_mask(*w, _mm512_setzero_si512()) & (wins ^ flip));
}

COHSM__TARGET_AVX512 static inline __m512i cohsm__edge16(__m512i ax, __m512i ay, __m512i bx, __m512i by)
{
    return _mm512_sub_epi32(_mm512_mullo_epi32(ax, by), _mm512_mullo_epi32(bx, ay));
}

/* cohsm__sample8 */
COHSM__TARGET_AVX512 static void cohsm__sample16(const cohsm__target *t, const cohsm__corners16 *c, __m512i x,
                                                 __m512i y, __mmask16 wanted)
{
    __m512i sx = _mm512_add_epi32(_mm512_slli_epi32(x, 8), _mm512_set1_epi32(128));
    __m512i sy = _mm512_add_epi32(_mm512_slli_epi32(y, 8), _mm512_set1_epi32(128));
    __m512i x0 = _mm512_sub_epi32(c->x[0], sx), y0 = _mm512_sub_epi32(c->y[0], sy);
    __m512i x1 = _mm512_sub_epi32(c->x[1], sx), y1 = _mm512_sub_epi32(c->y[1], sy);
    __m512i x2 = _mm512_sub_epi32(c->x[2], sx), y2 = _mm512_sub_epi32(c->y[2], sy);
    __m512i w0 = cohsm__edge16(x1, y1, x2, y2), w1 = cohsm__edge16(x2, y2, x0, y0), w2 = cohsm__edge16(x0, y0, x1, y1);
    __m512i area = _mm512_add_epi32(_mm512_add_epi32(w0, w1), w2), zero = _mm512_setzero_si512();
    __mmask16 flip = _mm512_cmplt_epi32_mask(area, zero);
    __m512 a, b, z, top = _mm512_set1_ps((float)COHSM__HIT_MAX);
    uint32_t pixel[16], depth[16];
    unsigned mask;

    area = _mm512_abs_epi32(area);
    mask = wanted & _mm512_cmpgt_epi32_mask(area, zero) & cohsm__inside16(x1, y1, x2, y2, flip, &w0) &
           cohsm__inside16(x2, y2, x0, y0, flip, &w1) & cohsm__inside16(x0, y0, x1, y1, flip, &w2);
    if (!mask) return;
    a = _mm512_mul_ps(_mm512_cvtepi32_ps(w1), c->z[1]);     /* added in the order of the corners as they face us */
    b = _mm512_mul_ps(_mm512_cvtepi32_ps(w2), c->z[2]);
    z = _mm512_add_ps(_mm512_mul_ps(_mm512_cvtepi32_ps(w0), c->z[0]), _mm512_mask_blend_ps(flip, a, b));
    z = _mm512_add_ps(z, _mm512_mask_blend_ps(flip, b, a));
    z = _mm512_mul_ps(z, _mm512_div_ps(_mm512_set1_ps(1.0f), _mm512_cvtepi32_ps(area)));
    z = _mm512_min_ps(_mm512_max_ps(_mm512_mul_ps(z, top), _mm512_setzero_ps()), top);
    _mm512_storeu_si512(depth, _mm512_cvttps_epi32(z));
    _mm512_storeu_si512(pixel, _mm512_add_epi32(_mm512_mullo_epi32(y, _mm512_set1_epi32(t->size)), x));
    for (; mask; mask &= mask - 1u) {
        unsigned lane = _tzcnt_u32(mask);
        cohsm__insert(t->z + (size_t)t->keep * pixel[lane], t->keep, (uint16_t)depth[lane]);
    }
}

/* The first 16 of the queue, or as many as there are. */
COHSM__TARGET_AVX512 static void cohsm__raster_queue16(const cohsm__target *t, const cohsm__camera *cam,
                                                       const cohsm__queue *q, uint32_t at)
{
    unsigned valid = q->count - at < 16u ? (1u << (q->count - at)) - 1u : 0xffffu, large;
    __m512i few = _mm512_set1_epi32(4), one = _mm512_set1_epi32(1), x, y, lx, ly, hx, hy;
    cohsm__corners16 c;
    cohsm__corner p[3];
    __mmask16 wide, row, wanted;
    int k;

    COHSM__UNROLL
    for (k = 0; k < 3; k++) {
        c.x[k] = _mm512_loadu_si512(q->x[k] + at);
        c.y[k] = _mm512_loadu_si512(q->y[k] + at);
        c.z[k] = _mm512_loadu_ps(q->z[k] + at);
    }
    cohsm__span16(c.x, 0, t->size, &lx, &hx);
    cohsm__span16(c.y, t->row_begin, t->row_end, &ly, &hy);
    wide = _mm512_cmpgt_epi32_mask(_mm512_sub_epi32(hx, lx), few) |
           _mm512_cmpgt_epi32_mask(_mm512_sub_epi32(hy, ly), few);
    for (large = wide & valid; large; large &= large - 1u) {
        uint32_t lane = _tzcnt_u32(large);
        for (k = 0; k < 3; k++) {
            p[k].x = q->x[k][at + lane];
            p[k].y = q->y[k][at + lane];
            p[k].z = q->z[k][at + lane];
        }
        cohsm__fill(t, cam, p, p + 1, p + 2);
    }
    for (y = ly;; y = _mm512_add_epi32(y, one)) {
        row = _mm512_mask_cmple_epi32_mask((__mmask16)(valid & ~(unsigned)wide), y, hy);
        if (!row) break;
        for (x = lx;; x = _mm512_add_epi32(x, one)) {
            wanted = _mm512_mask_cmple_epi32_mask(row, x, hx);
            if (!wanted) break;
            cohsm__sample16(t, &c, x, y, wanted);
        }
    }
}

/* cohsm__drain8 */
COHSM__TARGET_AVX512 static void cohsm__drain16(const cohsm__target *t, const cohsm__camera *cam, cohsm__queue *q,
                                                int all)
{
    uint32_t at = 0;
    int k;
    for (; q->count - at >= (all ? 1u : 16u) && q->count > at; at += 16) cohsm__raster_queue16(t, cam, q, at);
    if (!at) return;
    q->count -= cohsm__min_u32(q->count, at);
    COHSM__UNROLL
    for (k = 0; k < 3; k++) {
        _mm512_storeu_si512(q->x[k], _mm512_loadu_si512(q->x[k] + at));
        _mm512_storeu_si512(q->y[k], _mm512_loadu_si512(q->y[k] + at));
        _mm512_storeu_ps(q->z[k], _mm512_loadu_ps(q->z[k] + at));
    }
}

COHSM__TARGET_AVX512 static void cohsm__raster_avx512(const cohsm__target *t, const cohsm__camera *cam,
                                                      const cohsm__soup *soup, const cohsm__sight *sight,
                                                      cohsm__queue *q)
{
    float scale = (float)(t->size * (COHSM__SUBPIXEL / 2));
    cohsm__v3 r = cohsm__v3_scale(cam->frame.right, scale), u = cohsm__v3_scale(cam->frame.up, scale);
    cohsm__v3 b = cam->frame.back;
    __m512 offset = _mm512_set1_ps(scale + 0.5f), half = _mm512_set1_ps(0.5f), corner[3], z;
    __m512i x[3], y[3], lx, hx, ly, hy;
    uint32_t count = q->count, at;
    int k, i;

    for (at = 0; at < sight->count; at++) {
        const float *v = cohsm__group(soup, sight->cluster[at], 0);
        __mmask16 mask;
        COHSM__UNROLL
        for (k = 0; k < 3; k++) {
            COHSM__UNROLL
            for (i = 0; i < 3; i++) corner[i] = cohsm__two8(v + COHSM__LANES * (3 * k + i));
            x[k] = _mm512_cvttps_epi32(_mm512_add_ps(cohsm__dot16(corner, r), offset));
            y[k] = _mm512_cvttps_epi32(_mm512_add_ps(cohsm__dot16(corner, u), offset));
        }
        cohsm__span16(x, 0, t->size, &lx, &hx);
        cohsm__span16(y, t->row_begin, t->row_end, &ly, &hy);
        mask = _mm512_cmple_epi32_mask(lx, hx) & _mm512_cmple_epi32_mask(ly, hy);
        COHSM__UNROLL
        for (k = 0; k < 3; k++) {
            COHSM__UNROLL
            for (i = 0; i < 3; i++) corner[i] = cohsm__two8(v + COHSM__LANES * (3 * k + i));
            z = _mm512_sub_ps(half, _mm512_mul_ps(half, cohsm__dot16(corner, b)));
            _mm512_storeu_si512(q->x[k] + count, _mm512_maskz_compress_epi32(mask, x[k]));
            _mm512_storeu_si512(q->y[k] + count, _mm512_maskz_compress_epi32(mask, y[k]));
            _mm512_storeu_ps(q->z[k] + count, _mm512_maskz_compress_ps(mask, z));
        }
        count += (uint32_t)_mm_popcnt_u32(mask);
        if (count <= COHSM__MANY) continue;
        q->count = count;
        cohsm__drain16(t, cam, q, 0);
        count = q->count;
    }
    q->count = count;
}
COHSM__AVX512_END
#endif

/* Perspective: triangles are cut to |x|, |y| <= 2 w, so that fixed-point positions stay small, and to w >= near. */
typedef struct cohsm__clip { float x, y, w; } cohsm__clip;

static float cohsm__clip_distance(const cohsm__clip *c, int plane)
{
    switch (plane) {
    case 0: return c->w - 1e-5f;
    case 1: return 2.0f * c->w - c->x;
    case 2: return 2.0f * c->w + c->x;
    case 3: return 2.0f * c->w - c->y;
    default: return 2.0f * c->w + c->y;
    }
}

/* The cut is computed from the inner end, whichever way the edge runs: both its triangles get the same corner. */
static cohsm__clip cohsm__clip_cut(const cohsm__clip *in, const cohsm__clip *out, float din, float dout)
{
    cohsm__clip c;
    float t = din / (din - dout);
    c.x = in->x + (out->x - in->x) * t;
    c.y = in->y + (out->y - in->y) * t;
    c.w = in->w + (out->w - in->w) * t;
    return c;
}

static int cohsm__clip_polygon(cohsm__clip *p, int count)
{
    cohsm__clip q[10];
    int plane, i, n;

    for (plane = 0; plane < 5; plane++) {
        for (i = 0, n = 0; i < count; i++) {
            const cohsm__clip *a = p + i, *b = p + (i + 1 == count ? 0 : i + 1);
            float da = cohsm__clip_distance(a, plane), db = cohsm__clip_distance(b, plane);
            if (da >= 0.0f) q[n++] = *a;
            if (da >= 0.0f && db < 0.0f) q[n++] = cohsm__clip_cut(a, b, da, db);
            if (da < 0.0f && db >= 0.0f) q[n++] = cohsm__clip_cut(b, a, db, da);
        }
        count = n;
        if (count < 3) return 0;
        memcpy(p, q, sizeof *p * (size_t)count);
    }
    return count;
}

static cohsm__corner cohsm__project(const cohsm__clip *c, int size)
{
    cohsm__corner p;
    float scale = (float)(size * (COHSM__SUBPIXEL / 2)), inverse = 1.0f / c->w, offset = scale * 3.0f + 0.5f;
    /* offset by one image first: conversion to int then truncates downwards everywhere */
    p.x = (int32_t)(c->x * inverse * scale + offset) - size * COHSM__SUBPIXEL;
    p.y = (int32_t)(c->y * inverse * scale + offset) - size * COHSM__SUBPIXEL;
    p.z = inverse;
    return p;
}

static void cohsm__raster_perspective(const cohsm__target *t, const cohsm__camera *cam, const float *v, uint32_t lane)
{
    cohsm__clip p[10];
    cohsm__corner c0, c1, c2;
    int k, n = 3, behind = 0, left = 0, right = 0, below = 0, above = 0, inside = 0;

    for (k = 0; k < 3; k++, v += 3 * COHSM__LANES) {
        cohsm__v3 q = cohsm__v3_sub(cohsm__v3_make(v[lane], v[8 + lane], v[16 + lane]), cam->eye);
        cohsm__face_coordinates(cam->face, q, &p[k].x, &p[k].y, &p[k].w);
        behind += p[k].w < 1e-5f;
        left += p[k].x < -p[k].w;
        right += p[k].x > p[k].w;
        below += p[k].y < -p[k].w;
        above += p[k].y > p[k].w;
        inside += p[k].w >= 1e-5f && fabsf(p[k].x) <= 2.0f * p[k].w && fabsf(p[k].y) <= 2.0f * p[k].w;
    }
    if (behind == 3 || left == 3 || right == 3 || below == 3 || above == 3) return;
    if (inside < 3) n = cohsm__clip_polygon(p, 3);
    if (n < 3) return;
    c0 = cohsm__project(p, t->size);
    c1 = cohsm__project(p + 1, t->size);
    for (k = 2; k < n; k++) {
        c2 = cohsm__project(p + k, t->size);
        cohsm__fill(t, cam, &c0, &c1, &c2);
        c1 = c2;
    }
}

/* Can the unit sphere be seen in this face at all? */
static int cohsm__face_sees_sphere(const cohsm__camera *cam)
{
    cohsm__v3 q = cohsm__v3_scale(cam->eye, -1.0f);
    float x, y, w;
    cohsm__face_coordinates(cam->face, q, &x, &y, &w);
    return w > -1.001f && fabsf(x) - w < 1.4157f && fabsf(y) - w < 1.4157f;
}

static uint32_t cohsm__append(uint32_t *list, uint32_t count, unsigned mask, uint32_t first)
{
    for (; mask; mask >>= 1, first++)
        if (mask & 1u) list[count++] = first;
    return count;
}

/* Of the clusters begin .. end - 1, no more than a stretch, those that may be in sight: by the boxes of eight first. */
static void cohsm__find(const cohsm__target *t, const cohsm__camera *cam, const cohsm__soup *soup, uint32_t begin,
                        uint32_t end, cohsm__sight *sight)
{
    unsigned (*sees8)(const cohsm__target *, const cohsm__camera *, const float *) =
        cam->perspective ? cohsm__face_sees8 : cohsm__sees8;
    const float *wide = cohsm__wide_bounds(soup);
    uint32_t eight[COHSM__STRETCH / 8 + 8], eights = cohsm__eights(end), count = 0, i;

    for (i = begin / 8; i < eights; i += 8)
        count = cohsm__append(eight, count, sees8(t, cam, wide + 6 * (size_t)i) & cohsm__first8(eights - i), i);
    for (i = 0, sight->count = 0; i < count; i++)
        sight->count = cohsm__append(sight->cluster, sight->count, sees8(t, cam, soup->bounds + 48 * (size_t)eight[i]) &
                                     cohsm__first8(end - 8 * eight[i]), 8 * eight[i]);
}

static void cohsm__raster_sight(const cohsm__target *t, const cohsm__camera *cam, const cohsm__soup *soup,
                                const cohsm__sight *sight)
{
    uint32_t i, lane;

    if (!cam->perspective)
        for (i = 0; i < sight->count; i++) {
            cohsm__raster_group(t, cam, cohsm__group(soup, sight->cluster[i], 0));
            cohsm__raster_group(t, cam, cohsm__group(soup, sight->cluster[i], 1));
        }
    else
        for (i = 0; i < sight->count; i++)
            for (lane = 0; lane < 2 * COHSM__LANES; lane++)
                cohsm__raster_perspective(t, cam, cohsm__group(soup, sight->cluster[i], lane / 8u),
                                          lane % 8u);
}

static void cohsm__raster(const cohsm__target *t, const cohsm__camera *cam, const cohsm__soup *soup, int simd)
{
    size_t first = (size_t)(t->row_begin * t->size) * t->keep, last = (size_t)(t->row_end * t->size) * t->keep;
    int all = !cam->perspective && t->row_begin == 0 && t->row_end == t->size;
    uint32_t clusters = cohsm__clusters(soup), begin, end, i;
    cohsm__sight sight;
    cohsm__queue q;

    memset(t->z + first, 0xff, (last - first) * sizeof *t->z);
    if (cam->perspective) {
        if (!cohsm__face_sees_sphere(cam)) return;
        simd = 0;
    }
    memset(&q, 0, sizeof q);
    for (begin = 0; begin < clusters; begin = end) {
        end = cohsm__min_u32(begin + COHSM__STRETCH, clusters);
        for (i = begin; all && i < end; i++) sight.cluster[i - begin] = i;
        sight.count = end - begin;
        if (!all && !simd) cohsm__find(t, cam, soup, begin, end, &sight);
        if (!simd) cohsm__raster_sight(t, cam, soup, &sight);
#if COHSM__SIMD
        if (!all && simd) cohsm__find_avx2(t, cam, soup, begin, end, &sight);
        if (simd) (simd == 2 ? cohsm__raster_avx512 : cohsm__raster_avx2)(t, cam, soup, &sight, &q);
#endif
    }
#if COHSM__SIMD
    if (simd) (simd == 2 ? cohsm__drain16 : cohsm__drain8)(t, cam, &q, 1);
#endif
}

/* ---- >>mesh: checked, normalised triangles ---- */

static const uint32_t *cohsm__corners(const cohsm_mesh *m, size_t triangle, uint32_t *scratch)
{
    if (m->indices) return m->indices + 3 * triangle;
    scratch[0] = (uint32_t)(3 * triangle);
    scratch[1] = scratch[0] + 1;
    scratch[2] = scratch[0] + 2;
    return scratch;
}

static cohsm__v3 cohsm__vertex(const cohsm_mesh *m, uint32_t i)
{
    size_t stride = m->vertex_stride ? m->vertex_stride : 12;
    float p[3];
    memcpy(p, (const char *)m->positions + stride * i, sizeof p);
    return cohsm__v3_load(p);
}

static size_t cohsm__triangle_count(const cohsm_mesh *m) { return (m->indices ? m->index_count : m->vertex_count) / 3; }

static cohsm_result cohsm__check_mesh(const cohsm_mesh *m)
{
    size_t i, count;
    if (!m || !m->positions || !m->vertex_count) return COHSM_ERR_ARGUMENT;
    if (m->vertex_count > 0x7fffffffu || (m->indices && m->index_count > 0x7fffffffu)) return COHSM_ERR_LIMIT;
    if (m->vertex_stride && (m->vertex_stride < 12 || m->vertex_stride % 4)) return COHSM_ERR_INPUT;
    count = m->indices ? m->index_count : m->vertex_count;
    if (count == 0 || count % 3) return COHSM_ERR_INPUT;
    if (m->indices)
        for (i = 0; i < count; i++)
            if (m->indices[i] >= m->vertex_count) return COHSM_ERR_INPUT;
    return COHSM_OK;
}

/* The order of a triangle's corners by position, so that copies of it compare equal whatever their winding. */
static int cohsm__less(cohsm__v3 a, cohsm__v3 b)
{
    if (a.x < b.x || a.x > b.x) return a.x < b.x;
    if (a.y < b.y || a.y > b.y) return a.y < b.y;
    return a.z < b.z;
}

static void cohsm__sort3(cohsm__v3 *p)
{
    cohsm__v3 t;
    int i;
    for (i = 0; i < 3; i++)
        if (cohsm__less(p[i == 1 ? 2 : 1], p[i == 1 ? 1 : 0])) {
            t = p[i == 1 ? 1 : 0];
            p[i == 1 ? 1 : 0] = p[i == 1 ? 2 : 1];
            p[i == 1 ? 2 : 1] = t;
        }
}

static int cohsm__equal(cohsm__v3 a, cohsm__v3 b) { return !cohsm__less(a, b) && !cohsm__less(b, a); }

static uint32_t cohsm__hash_corners(const cohsm__v3 *p)
{
    uint32_t h = 0, bits, i, k;
    for (i = 0; i < 3; i++)
        for (k = 0; k < 3; k++) {
            float f = (k == 0 ? p[i].x : k == 1 ? p[i].y : p[i].z) + 0.0f;   /* -0 becomes 0 */
            memcpy(&bits, &f, sizeof bits);
            h = cohsm__hash_combine(h, bits);
        }
    return h;
}

/* used[t] = 1 for triangles that are rendered: finite, with three different corners, the first of its copies. Copies
   would put two equal depths into every map and so a segment of its own into every entry. */
static cohsm_result cohsm__select(const cohsm_mesh *mesh, uint8_t *used, cohsm__heap *heap, cohsm_stats *stats)
{
    size_t count = cohsm__triangle_count(mesh), slots = 16, t, s;
    uint32_t *table, scratch[3], scratch2[3];
    int k, copy;

    while (slots < 2 * count) slots *= 2;
    table = (uint32_t *)cohsm__take(heap, slots, sizeof *table);
    if (!table) return COHSM_ERR_ALLOC;
    memset(table, 0, slots * sizeof *table);
    for (t = 0; t < count; t++) {
        const uint32_t *c = cohsm__corners(mesh, t, scratch);
        cohsm__v3 p[3], q[3];
        for (k = 0; k < 3; k++) p[k] = cohsm__vertex(mesh, c[k]);
        used[t] = 0;
        if (!cohsm__v3_finite(p[0]) || !cohsm__v3_finite(p[1]) || !cohsm__v3_finite(p[2]) ||
            cohsm__equal(p[0], p[1]) || cohsm__equal(p[1], p[2]) || cohsm__equal(p[2], p[0])) {
            stats->skipped_triangles++;
            continue;
        }
        cohsm__sort3(p);
        for (s = cohsm__hash_corners(p) & (slots - 1), copy = 0; table[s] && !copy; s = (s + 1) & (slots - 1)) {
            c = cohsm__corners(mesh, table[s] - 1u, scratch2);
            for (k = 0; k < 3; k++) q[k] = cohsm__vertex(mesh, c[k]);
            cohsm__sort3(q);
            copy = cohsm__equal(p[0], q[0]) && cohsm__equal(p[1], q[1]) && cohsm__equal(p[2], q[2]);
        }
        if (copy) {
            stats->duplicate_triangles++;
            continue;
        }
        table[s] = (uint32_t)t + 1u;
        used[t] = 1;
        stats->triangles++;
    }
    cohsm__give(heap, table, slots, sizeof *table);
    return stats->triangles ? COHSM_OK : COHSM_ERR_INPUT;
}

/* Corners of used triangles, each once, in the order in which the triangles name them. */
typedef struct cohsm__points { float (*at)[3]; size_t count, room; } cohsm__points;

static int cohsm__points_make(cohsm__points *points, const cohsm_mesh *mesh, const uint8_t *used, uint32_t triangles,
                              cohsm__heap *heap)
{
    size_t count = cohsm__triangle_count(mesh), bytes = mesh->vertex_count / 8u + 1u, t;
    uint8_t *met = (uint8_t *)cohsm__take(heap, bytes, 1);
    uint32_t scratch[3], i;
    int k;

    points->count = 0;
    points->room = 3 * (size_t)triangles < mesh->vertex_count ? 3 * (size_t)triangles : mesh->vertex_count;
    points->at = (float (*)[3])cohsm__take(heap, points->room, sizeof *points->at);
    if (met && points->at) {
        memset(met, 0, bytes);
        for (t = 0; t < count; t++)
            for (k = 0; used[t] && k < 3; k++) {
                i = cohsm__corners(mesh, t, scratch)[k];
                if ((uint32_t)met[i / 8u] >> (i % 8u) & 1u) continue;
                met[i / 8u] = (uint8_t)(met[i / 8u] | 1u << (i % 8u));
                cohsm__v3_store(points->at[points->count++], cohsm__vertex(mesh, i));
            }
    }
    cohsm__give(heap, met, bytes, 1);
    return points->count != 0;
}

static void cohsm__points_free(cohsm__points *points, cohsm__heap *heap)
{
    cohsm__give(heap, points->at, points->room, sizeof *points->at);
}

/* Squared distance of the farthest; of equals the first. */
static double cohsm__farthest(const cohsm__points *points, const double *c, size_t *where)
{
    double far2 = -1.0, x, y, z, d2;
    size_t i;

    *where = 0;
    for (i = 0; i < points->count; i++) {
        x = (double)points->at[i][0] - c[0];
        y = (double)points->at[i][1] - c[1];
        z = (double)points->at[i][2] - c[2];
        d2 = x * x + y * y + z * z;
        if (d2 <= far2) continue;
        far2 = d2;
        *where = i;
    }
    return far2;
}

/* The smallest sphere, nearly: from the middle of the box, steps of 1/2, 1/3, 1/4 ... towards the farthest corner
   (Badoiu and Clarkson, "Smaller core-sets for balls", SODA 2003). */
static void cohsm__fit_sphere(const cohsm__points *points, float *center, float *radius)
{
    double c[3], best = -1.0, far2;
    cohsm__v3 lo = cohsm__v3_load(points->at[0]), hi = lo;
    size_t i;
    int step, k;

    for (i = 1; i < points->count; i++) {
        lo = cohsm__v3_min(lo, cohsm__v3_load(points->at[i]));
        hi = cohsm__v3_max(hi, cohsm__v3_load(points->at[i]));
    }
    c[0] = 0.5 * ((double)lo.x + (double)hi.x);
    c[1] = 0.5 * ((double)lo.y + (double)hi.y);
    c[2] = 0.5 * ((double)lo.z + (double)hi.z);
    for (step = 1; step <= 64; step++) {
        far2 = cohsm__farthest(points, c, &i);
        if (best < 0.0 || far2 < best) {
            best = far2;
            for (k = 0; k < 3; k++) center[k] = (float)c[k];
        }
        for (k = 0; k < 3; k++) c[k] += ((double)points->at[i][k] - c[k]) / (step + 1);
    }
    for (k = 0; k < 3; k++) c[k] = (double)center[k];       /* as it is stored */
    *radius = (float)(sqrt(cohsm__farthest(points, c, &i)) * 1.00001);
}

/* A little beyond what rounding of the centre may have lost. */
static int cohsm__sphere_holds(const cohsm__points *points, const float *center, float radius)
{
    double c[3];
    size_t i;
    int k;
    for (k = 0; k < 3; k++) c[k] = (double)center[k];
    return cohsm__farthest(points, c, &i) <= (double)radius * (double)radius * 1.0001;
}

/* Axes of the k-DOP: the faces, edges and corners of a cube. */
static cohsm__v3 cohsm__dop_axis(int i)
{
    static const signed char axis[COHSM__DOP_AXES][3] = {
        { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 1, 0 }, { 1, -1, 0 }, { 1, 0, 1 }, { 1, 0, -1 },
        { 0, 1, 1 }, { 0, 1, -1 }, { 1, 1, 1 }, { 1, 1, -1 }, { 1, -1, 1 }, { -1, 1, 1 }
    };
    return cohsm__v3_make((float)axis[i][0], (float)axis[i][1], (float)axis[i][2]);
}

static void cohsm__dop_of_sphere(float *dop, const float *center, float radius)
{
    int i;
    for (i = 0; i < COHSM__DOP_AXES; i++) {
        cohsm__v3 a = cohsm__dop_axis(i);
        float middle = cohsm__v3_dot(a, cohsm__v3_load(center)), reach = cohsm__v3_length(a) * radius;
        dop[2 * i] = middle - reach;
        dop[2 * i + 1] = middle + reach;
    }
}

static void cohsm__dop_of_points(float *dop, const cohsm__points *points)
{
    size_t n;
    int i;
    for (n = 0; n < points->count; n++)
        for (i = 0; i < COHSM__DOP_AXES; i++) {
            float d = cohsm__v3_dot(cohsm__dop_axis(i), cohsm__v3_load(points->at[n]));
            if (!n || d < dop[2 * i]) dop[2 * i] = d;
            if (!n || d > dop[2 * i + 1]) dop[2 * i + 1] = d;
        }
}

/* Corners of a triangle in units of the sphere. */
static void cohsm__soup_corners(const cohsm_mesh *mesh, size_t triangle, cohsm__v3 center, float inverse, cohsm__v3 *p)
{
    uint32_t scratch[3];
    const uint32_t *corner = cohsm__corners(mesh, triangle, scratch);
    int k;
    for (k = 0; k < 3; k++) p[k] = cohsm__v3_scale(cohsm__v3_sub(cohsm__vertex(mesh, corner[k]), center), inverse);
}

/* Where a triangle lies: the sum of its corners. */
typedef struct cohsm__spot { float at[3]; uint32_t triangle; } cohsm__spot;

static uint32_t cohsm__bin(const cohsm__spot *p, int axis, float low, float scale)
{
    return cohsm__min_u32((uint32_t)((p->at[axis] - low) * scale), 255u);
}

/* The first half of them on one side of the rest, along the longest axis of their box. Counted in 256 bins: those in
   the bin of the limit may go to either side, so that time is linear whatever the mesh. */
static void cohsm__halve(cohsm__spot *p, uint32_t count, uint32_t half)
{
    uint32_t bins[256], i, middle, left, store, bin;
    float low[3], high[3], scale;
    cohsm__spot moved;
    int axis = 0, k;

    for (k = 0; k < 3; k++) low[k] = high[k] = p->at[k];
    for (i = 1; i < count; i++)
        for (k = 0; k < 3; k++) {
            low[k] = p[i].at[k] < low[k] ? p[i].at[k] : low[k];
            high[k] = p[i].at[k] > high[k] ? p[i].at[k] : high[k];
        }
    for (k = 1; k < 3; k++)
        if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
    if (!(high[axis] - low[axis] > 1e-30f)) return;
    scale = 255.0f / (high[axis] - low[axis]);
    memset(bins, 0, sizeof bins);
    for (i = 0; i < count; i++) bins[cohsm__bin(p + i, axis, low[axis], scale)]++;
    for (middle = 0, left = half; bins[middle] <= left && middle < 255u; middle++) left -= bins[middle];
    for (i = 0, store = 0; i < count; i++) {
        bin = cohsm__bin(p + i, axis, low[axis], scale);
        if (bin > middle || (bin == middle && !left)) continue;
        left -= (uint32_t)(bin == middle);
        moved = p[i];
        p[i] = p[store];
        p[store++] = moved;
    }
}

/* In the order of the mesh, whose neighbours often share what becomes of them: branches are foreseen better. */
static void cohsm__sort_leaf(cohsm__spot *p, uint32_t count)
{
    uint32_t i, j;
    for (i = 1; i < count; i++) {
        cohsm__spot moved = p[i];
        for (j = i; j && p[j - 1u].triangle > moved.triangle; j--) p[j] = p[j - 1u];
        p[j] = moved;
    }
}

/* Neighbours in space one after the other: halves of halves, in whole clusters and, above these, in eights of clusters.
   todo has room for any: a half is no larger than the rest by more than a unit. */
static void cohsm__sort_spots(cohsm__spot *p, uint32_t count)
{
    enum { LEAF = 2 * COHSM__LANES };
    struct { cohsm__spot *p; uint32_t count; } todo[32];
    uint32_t waiting = 0, unit, half;

    for (;;)
        if (count > LEAF) {
            unit = count > 8 * LEAF ? 8 * LEAF : LEAF;
            half = (count + unit - 1u) / unit / 2u * unit;
            cohsm__halve(p, count, half);
            todo[waiting].p = p + half;
            todo[waiting++].count = count - half;
            count = half;
        } else {
            cohsm__sort_leaf(p, count);
            if (!waiting) return;
            p = todo[--waiting].p;
            count = todo[waiting].count;
        }
}

/* The box of groups that lie one after the other, a little enlarged. */
static void cohsm__bound(const float *v, uint32_t groups, float *box)
{
    float low[3] = { 2.0f, 2.0f, 2.0f }, high[3] = { -2.0f, -2.0f, -2.0f };
    uint32_t i, k;
    for (i = 0; i < 9 * COHSM__LANES * groups; i++) {
        k = i / COHSM__LANES % 3;
        low[k] = v[i] < low[k] ? v[i] : low[k];
        high[k] = v[i] > high[k] ? v[i] : high[k];
    }
    for (k = 0; k < 3; k++) {
        box[8 * k] = 0.5f * (low[k] + high[k]);
        box[24 + 8 * k] = 0.5f * (high[k] - low[k]) + 1e-5f;
    }
}

/* Boxes of each span groups, from bounds on. */
static void cohsm__bound_all(const cohsm__soup *soup, uint32_t span, float *bounds)
{
    uint32_t i, at;
    for (i = 0, at = 0; i < soup->groups; i += span, at++)
        cohsm__bound(soup->v + (size_t)i * 9 * COHSM__LANES, cohsm__min_u32(span, soup->groups - i),
                     bounds + 48 * (size_t)(at / 8) + at % 8);
}

static void cohsm__soup_fill(cohsm__soup *soup, const cohsm_mesh *mesh, const uint8_t *used, cohsm__spot *spot,
                             cohsm__v3 center, float inverse)
{
    size_t count = cohsm__triangle_count(mesh), t;
    cohsm__v3 p[3];
    uint32_t n = 0;
    float *v;
    int k;

    for (t = 0; t < count; t++) {
        if (!used[t]) continue;
        cohsm__soup_corners(mesh, t, center, inverse, p);
        cohsm__v3_store(spot[n].at, cohsm__v3_add(cohsm__v3_add(p[0], p[1]), p[2]));
        spot[n++].triangle = (uint32_t)t;
    }
    cohsm__sort_spots(spot, n);
    for (n = 0; n < soup->triangles; n++) {
        cohsm__soup_corners(mesh, spot[n].triangle, center, inverse, p);
        for (k = 0; k < 3; k++) {
            v = soup->v + (size_t)(n / COHSM__LANES) * 9 * COHSM__LANES + 3 * COHSM__LANES * k + n % COHSM__LANES;
            v[0] = p[k].x;
            v[COHSM__LANES] = p[k].y;
            v[2 * COHSM__LANES] = p[k].z;
        }
    }
}

/* Triangles sorted in space, so that clusters are small and a shard need not look into most of them. */
static int cohsm__soup_make(cohsm__soup *soup, const cohsm_mesh *mesh, const uint8_t *used, uint32_t triangles,
                            const float *center, float radius, cohsm__heap *heap)
{
    cohsm__spot *spot;
    size_t floats;
    int made;

    soup->triangles = triangles;
    soup->groups = (triangles + 2 * COHSM__LANES - 1) / (2 * COHSM__LANES) * 2;     /* whole sixteens */
    floats = (size_t)soup->groups * 9 * COHSM__LANES;
    soup->v = (float *)cohsm__take(heap, floats, sizeof(float));
    soup->bounds = (float *)cohsm__take(heap, cohsm__bound_count(soup), 48 * sizeof(float));
    spot = (cohsm__spot *)cohsm__take(heap, triangles, sizeof *spot);
    made = soup->v && soup->bounds && spot;
    if (made) {
        memset(soup->v, 0, floats * sizeof(float));
        memset(soup->bounds, 0, cohsm__bound_count(soup) * 48 * sizeof(float));
        cohsm__soup_fill(soup, mesh, used, spot, cohsm__v3_load(center), 1.0f / radius);
        cohsm__bound_all(soup, 2, soup->bounds);
        cohsm__bound_all(soup, 16, cohsm__wide_bounds(soup));
    }
    cohsm__give(heap, spot, triangles, sizeof *spot);
    return made;
}

static void cohsm__soup_free(cohsm__soup *soup, cohsm__heap *heap)
{
    cohsm__give(heap, soup->v, (size_t)soup->groups * 9 * COHSM__LANES, sizeof(float));
    cohsm__give(heap, soup->bounds, cohsm__bound_count(soup), 48 * sizeof(float));
    soup->v = soup->bounds = NULL;
}

/* ---- >>lists: the format ---- */

/* One pixel's depths over the views of a chunk are piecewise constant: segments, each with a first view and a depth.
   A list is cut into blocks of one cache line each; the last one, its tail, is as short as it can be and shares a line
   with the tails of other lists. A directory says where they are: one word each for the line of the first block; the
   count of blocks (low 16 bits), the word of the tail in its line (4 bits), and how many lines before the first block's
   that one is (12 bits); then 16 bits for the first view of every block but the first. A query so reads lookup and
   directory, which are small and stay in a near cache, and one line of the large rest.

   A block, read as a string of bits from the low end of its first word, is

     8 base, 4 k, 4 width     of the two fields below
     64 marks                 Elias-Fano: the block's views fall into buckets of 2^k; for each bucket a 1 for every
                              segment that begins in it, then a 0. The first segment begins at the block's first view
     n x k low bits           first view of each segment within its bucket
     n x width codes          width 1..9: depth on the grid, less base; all ones but the last bit: infinite
                              width 10..15: codes of width - 9 bits, places in a palette of base depths
                              all ones, in both: exact
     base x 8 bits            the palette, if there is one
     16 bits each             the exact depths, in order

   A search finds its bucket by counting zeros and compares a few low bits: whatever the number of segments, its time is
   the same. */

enum { COHSM__BLOCK_BITS = 32 * COHSM__BLOCK_WORDS, COHSM__MARKS = 64, COHSM__LOW_AT = 16 + COHSM__MARKS,
       COHSM__WIDEST = 9, COHSM__FARTHEST_TAIL = 4095 };

typedef struct cohsm__segment {
    uint16_t first;                     /* view within the chunk */
    uint16_t lo, hi;                    /* grid values that separate the layers; exact: lo = depth, hi unused */
    uint16_t exact;
} cohsm__segment;

/* 33 bits or more from any position: more than any field needs. */
static uint64_t cohsm__window(const uint32_t *words, uint32_t bit)
{
    const uint32_t *w = words + (bit >> 5);
    return (w[0] | (uint64_t)w[1] << 32) >> (bit & 31u);
}

/* A field of up to 30 bits of a block, 32 bits or more from its begin. Read with the word before its last one and never
   with the one after, which may be another line's: that miss would cost more than the whole search. */
static uint32_t cohsm__bits(const uint32_t *block, uint32_t bit, uint32_t count)
{
    uint32_t i = ((bit + count - 1u) >> 5) - 1u;
    const uint32_t *w = block + i;
    return (uint32_t)((w[0] | (uint64_t)w[1] << 32) >> (bit - 32u * i)) & ((1u << count) - 1u);
}

static void cohsm__put_bits(uint32_t *words, uint32_t bit, uint32_t count, uint32_t value)
{
    uint32_t *w = words + (bit >> 5);
    uint64_t shifted = (uint64_t)value << (bit & 31u);
    w[0] |= (uint32_t)(shifted & 0xffffffffu);
    if ((bit & 31u) + count > 32) w[1] |= (uint32_t)(shifted >> 32);
}

static uint32_t cohsm__half_word(const uint32_t *words, uint32_t i)
{
    return words[i >> 1] >> (16 * (i & 1u)) & 0xffffu;
}

static uint64_t cohsm__marks(const uint32_t *block)
{
    return (block[0] | (uint64_t)block[1] << 32) >> 16 | (uint64_t)block[2] << 48;
}

/* For each of the eight bytes from 0 to 127, 1 where it is at least x. */
static uint64_t cohsm__bytes_from(uint64_t bytes, uint32_t x)
{
    const uint64_t ones = 0x0101010101010101u, tops = 0x8080808080808080u;
    return (((bytes | tops) - x * ones) & tops) >> 7;
}

/* Position of the zero with this number (from 0); 64 where there are not so many. From the counts of zeros up to each
   byte, then from those up to each bit of the right byte. */
static uint32_t cohsm__select_zero(uint64_t marks, uint32_t number)
{
    const uint64_t ones = 0x0101010101010101u;
    uint64_t x = ~marks, upto;
    uint32_t at;

    number = number < 127 ? number + 1u : 127u;
    upto = x - (x >> 1 & 0x5555555555555555u);
    upto = (upto & 0x3333333333333333u) + (upto >> 2 & 0x3333333333333333u);
    upto = ((upto + (upto >> 4)) & 0x0f0f0f0f0f0f0f0fu) * ones;
    at = 64u - 8u * (uint32_t)(cohsm__bytes_from(upto, number) * ones >> 56);
    if (at == 64) return 64;
    number -= (uint32_t)(upto << 8 >> at) & 255u;
    upto = (((x >> at & 255u) * ones & 0x8040201008040201u) + 0x7f7f7f7f7f7f7f7fu) >> 7 & ones; /* a bit in each byte */
    return at + 8u - (uint32_t)(cohsm__bytes_from(upto * ones, number) * ones >> 56);
}

/* Where the fields of a block begin. */
typedef struct cohsm__fields { uint32_t n, k, bits, palette, codes_at, palette_at, exact_at; } cohsm__fields;

static cohsm__fields cohsm__block_fields(const uint32_t *block, uint32_t n)
{
    cohsm__fields f;
    f.n = n;
    f.k = block[0] >> 8 & 15u;
    f.bits = block[0] >> 12 & 15u;
    f.palette = f.bits > COHSM__WIDEST ? block[0] & 255u : 0u;
    if (f.bits > COHSM__WIDEST) f.bits -= COHSM__WIDEST;
    f.codes_at = COHSM__LOW_AT + n * f.k;
    f.palette_at = f.codes_at + n * f.bits;
    f.exact_at = f.palette_at + 8u * f.palette;
    return f;
}

/* The 16-bit depth of segment j in a block of n. Exact depths have as many predecessors as there are codes of all ones
   before j. */
static inline uint32_t cohsm__block_depth(const uint32_t *block, const uint16_t *depth_of, uint32_t n, uint32_t j)
{
    uint32_t head = block[0], bits = head >> 12 & 15u, palette = 0u - (uint32_t)(bits > COHSM__WIDEST), ones, codes_at;
    uint32_t code, value, i, rank = 0;

    bits -= (uint32_t)COHSM__WIDEST & palette;
    ones = (1u << bits) - 1u;
    codes_at = COHSM__LOW_AT + n * (head >> 8 & 15u);
    code = cohsm__bits(block, codes_at + j * bits, bits);
    if (code == ones) {
        for (i = 0; i < j; i++) rank += cohsm__bits(block, codes_at + i * bits, bits) == ones;
        return cohsm__bits(block, cohsm__block_fields(block, n).exact_at + 16 * rank, 16);
    }
    value = code + 1u == ones ? 511u : (head & 255u) + code;        /* infinite, as all places from the grid's top */
    code = cohsm__bits(block, codes_at + ((n * bits + 8u * code) & palette), 8);
    return depth_of[(code & palette) | (value & ~palette)];
}

/* Segment of a block that holds a view: offset = view less the block's first; at = where its bucket begins in the
   marks. No branches that data decides but for rare cases: a mispredicted one costs as much as ten instructions. */
static inline uint32_t cohsm__segment_at(const uint32_t *block, uint64_t marks, uint32_t offset, uint32_t at)
{
    uint32_t k = block[0] >> 8 & 15u, j = at - (offset >> k), mask = (1u << k) - 1u, low = offset & mask;
    uint32_t run, more, lows;

    run = (uint32_t)((marks >> (at & 63u)) & (at < 64 ? 7u : 0u));
    lows = cohsm__bits(block, COHSM__LOW_AT + j * k, 2u * k); /* two, or one and what follows: codes, never less */
    more = run & (uint32_t)((lows & mask) <= low);
    j += more & 1u;
    more &= run >> 1 & (uint32_t)(lows >> k <= low);
    j += more & 1u;
    if (more & run >> 2 & 1u)
        for (at += 2; at < 64 && (marks >> at & 1u) && cohsm__bits(block, COHSM__LOW_AT + j * k, k) <= low; at++) j++;
    return j - 1u;
}

static uint32_t cohsm__block_find(const uint32_t *block, uint32_t offset)
{
    uint64_t marks = cohsm__marks(block);
    uint32_t bucket = offset >> (block[0] >> 8 & 15u);
    return cohsm__segment_at(block, marks, offset, bucket ? cohsm__select_zero(marks, bucket - 1u) + 1u : 0u);
}

/* Words of a block, from its exact codes. */
static uint32_t cohsm__block_words(const uint32_t *block)
{
    cohsm__fields f = cohsm__block_fields(block, cohsm__popcount(cohsm__marks(block)));
    uint32_t j, size = f.exact_at, ones = (1u << f.bits) - 1u;
    for (j = 0; j < f.n; j++) size += cohsm__bits(block, f.codes_at + j * f.bits, f.bits) == ones ? 16u : 0u;
    return (size + 31u) / 32u;
}

static uint32_t cohsm__block_count(const uint32_t *directory) { return directory[1] & 0xffffu; }
static uint32_t cohsm__block_first(const uint32_t *directory, uint32_t b)
{
    return cohsm__half_word(directory, b + 3u);
}

static const uint32_t *cohsm__block_at(const uint32_t *directory, const uint32_t *lines, uint32_t b)
{
    uint32_t tail = directory[1] >> 16;
    if (b + 1u < cohsm__block_count(directory)) return lines + COHSM__BLOCK_WORDS * ((size_t)directory[0] + b);
    return lines + COHSM__BLOCK_WORDS * ((size_t)directory[0] - (tail >> 4)) + (tail & 15u);
}

/* The last block that begins at or before the view, which becomes relative to it. */
static const uint32_t *cohsm__list_block(const cohsm_maps *m, const uint32_t *directory, uint32_t *view)
{
    uint32_t lo = 0, count = cohsm__block_count(directory), half;
    for (; count > 1; count -= half) {              /* halving without branches */
        half = count / 2;
        lo += half & (0u - (uint32_t)(cohsm__block_first(directory, lo + half) <= *view));
    }
    if (lo) *view -= cohsm__block_first(directory, lo);
    return cohsm__block_at(directory, m->lines, lo);
}

static uint32_t cohsm__depth_in_block(const cohsm_maps *m, const uint32_t *block, uint32_t view)
{
    return cohsm__block_depth(block, m->depth_of, cohsm__popcount(cohsm__marks(block)), cohsm__block_find(block, view));
}

static uint32_t cohsm__stored_depth(const cohsm_maps *m, uint32_t pixel, uint32_t place)
{
    const uint32_t *block;
    uint32_t entry = m->lookup[(size_t)(place >> COHSM__CHUNK_BITS) * m->range + pixel];
    if (entry & COHSM__CONSTANT) return entry & 0xffffu;
    place &= COHSM__CHUNK - 1u;
    block = cohsm__list_block(m, m->directories + entry, &place);
    return cohsm__depth_in_block(m, block, place);
}

/* ---- >>encode: segments to lists ---- */

/* The grid of stored depths: values 0..top, top = infinite. */
typedef struct cohsm__grid { uint32_t top, margin; } cohsm__grid;

/* Of the values lo..hi, the middle leaves the most room on both sides (paper 3.1). But a value far behind the first hit
   lets light through to whatever is there, other objects among them; so it stays within two pixels of it. */
static uint32_t cohsm__choose(const cohsm__grid *g, uint32_t lo, uint32_t hi)
{
    uint32_t middle = (lo + hi) / 2u;
    return middle < lo + g->margin ? middle : lo + g->margin;
}

static cohsm__grid cohsm__grid_of(uint32_t depth_bits, uint32_t map_size)
{
    cohsm__grid g;
    g.top = (1u << depth_bits) - 1u;
    g.margin = (2u * g.top + map_size - 1u) / map_size;
    return g;
}

/* What the first n segments would take in one block. */
typedef struct cohsm__plan {
    uint32_t n, exact, least_hi, greatest_lo;   /* of the segments taken so far */
    uint32_t k, bits, base, values, size;
    uint32_t palette;                           /* entries, 0: none */
    uint8_t  value[COHSM__MARKS];
} cohsm__plan;

static void cohsm__plan_start(cohsm__plan *p)
{
    memset(p, 0, sizeof *p);
    p->least_hi = COHSM__INFINITE;
}

/* The fewest grid values with one in each interval: the least hi that is left must be met, and meeting it as late as
   possible meets the most others. Each value then moves to the middle of what its intervals have in common. */
static uint32_t cohsm__pierce(const cohsm__segment *s, uint32_t n, const cohsm__grid *grid, uint8_t *value,
                              uint8_t *code)
{
    uint8_t todo[COHSM__MARKS];
    uint32_t i, count = 0, left = 0, at, lo;

    for (i = 0; i < n; i++)
        if (!s[i].exact) todo[left++] = (uint8_t)i;
    for (; left; count++) {
        for (i = 0, at = grid->top; i < left; i++) {
            const cohsm__segment *t = &s[todo[i]];
            uint32_t hi = t->lo >= grid->top ? grid->top : cohsm__min_u32(t->hi, grid->top - 1u);
            at = cohsm__min_u32(at, hi);
        }
        for (i = 0, lo = 0, n = left, left = 0; i < n; i++) {
            if (s[todo[i]].lo <= at) {
                lo = cohsm__max_u32(lo, s[todo[i]].lo);
                if (code) code[todo[i]] = (uint8_t)count;
            } else todo[left++] = todo[i];
        }
        value[count] = (uint8_t)cohsm__choose(grid, lo, at);
    }
    return count;
}

static int cohsm__plan_size(cohsm__plan *p)
{
    p->size = COHSM__LOW_AT + p->n * (p->k + p->bits) + 8u * p->palette + 16u * p->exact;
    return p->size <= COHSM__BLOCK_BITS;
}

static int cohsm__plan_palette(cohsm__plan *p, const cohsm__segment *s, const cohsm__grid *grid)
{
    p->palette = cohsm__pierce(s, p->n, grid, p->value, NULL);
    for (p->bits = 1; (1u << p->bits) - 1u < p->palette; p->bits++) {}
    return p->palette && p->bits <= 15 - COHSM__WIDEST && cohsm__plan_size(p);
}

/* Takes one more segment; 0 where the block would become too long. end = first view after it. */
static int cohsm__plan_take(cohsm__plan *p, const cohsm__segment *s, const cohsm__grid *grid, uint32_t end)
{
    uint32_t span = end - s[0].first;
    const cohsm__segment *last = s + p->n;

    if (p->n == COHSM__MARKS) return 0;
    p->n++;
    if (last->exact) p->exact++;
    else if (last->lo < grid->top) {
        p->least_hi = cohsm__min_u32(p->least_hi, cohsm__min_u32(last->hi, grid->top - 1u));
        p->greatest_lo = cohsm__max_u32(p->greatest_lo, last->lo);
    }
    for (p->k = 0; p->n + ((span - 1u) >> p->k) > COHSM__MARKS; p->k++)
        if (p->k == 15) return 0;
    /* the narrowest range of grid values with one in each interval: from the least hi to the greatest lo */
    p->base = cohsm__min_u32(p->least_hi, p->greatest_lo);
    p->values = p->least_hi < p->greatest_lo ? p->greatest_lo - p->least_hi + 1u : 1u;
    if (p->least_hi == COHSM__INFINITE) p->base = 0;
    else if (p->least_hi > p->greatest_lo) p->base = cohsm__choose(grid, p->greatest_lo, p->least_hi);
    p->palette = 0;
    for (p->bits = 1; (1u << p->bits) - 2u < p->values; p->bits++) {}
    return cohsm__plan_size(p) || cohsm__plan_palette(p, s, grid);
}

static uint32_t cohsm__segment_end(const cohsm__segment *s, size_t i, size_t count, uint32_t views)
{
    return i + 1 < count ? s[i + 1].first : views;
}

/* As many segments as fit; the shorter kind for a tail. */
static cohsm__plan cohsm__plan_block(const cohsm__segment *s, size_t count, const cohsm__grid *grid, uint32_t views)
{
    cohsm__plan best, next;
    cohsm__plan_start(&next);
    best = next;
    while (next.n < count && cohsm__plan_take(&next, s, grid, cohsm__segment_end(s, next.n, count, views))) best = next;
    next = best;
    if (best.n == count && !best.palette && cohsm__plan_palette(&next, s, grid) && next.size < best.size) best = next;
    return best;
}

static uint32_t cohsm__range_code(const cohsm__segment *s, const cohsm__plan *p, const cohsm__grid *grid)
{
    uint32_t value = cohsm__choose(grid, s->lo, cohsm__min_u32(s->hi, grid->top - 1u));
    if (s->lo >= grid->top) return (1u << p->bits) - 2u;
    return cohsm__max_u32(p->base, cohsm__min_u32(value, p->base + p->values - 1u)) - p->base;
}

static void cohsm__write_block(uint32_t *block, const cohsm__segment *s, cohsm__plan *p,
                               const cohsm__grid *grid)
{
    uint32_t i, offset, bucket = 0, at = 16, code, head = p->palette ? p->palette : p->base;
    uint8_t place[COHSM__MARKS];
    cohsm__fields f;

    cohsm__put_bits(block, 0, 16, head | p->k << 8 | (p->palette ? p->bits + COHSM__WIDEST : p->bits) << 12);
    f = cohsm__block_fields(block, p->n);
    if (p->palette) cohsm__pierce(s, p->n, grid, p->value, place);
    for (i = 0; i < p->n; i++) {
        offset = (uint32_t)s[i].first - s[0].first;
        at += (offset >> p->k) - bucket;
        bucket = offset >> p->k;
        cohsm__put_bits(block, at++, 1, 1);
        cohsm__put_bits(block, COHSM__LOW_AT + i * p->k, p->k, offset & ((1u << p->k) - 1u));
        code = s[i].exact ? (1u << p->bits) - 1u : p->palette ? place[i] : cohsm__range_code(s + i, p, grid);
        cohsm__put_bits(block, f.codes_at + i * f.bits, f.bits, code);
        if (s[i].exact) {
            cohsm__put_bits(block, f.exact_at, 16, s[i].lo);
            f.exact_at += 16;
        }
    }
    for (i = 0; i < p->palette; i++) cohsm__put_bits(block, f.palette_at + 8 * i, 8, p->value[i]);
}

/* Blocks of a list are at most this many: one takes 10 segments at least, all of them exact, or all that are left. */
static size_t cohsm__blocks_bound(size_t count) { return count / 10 + 1; }

static size_t cohsm__list_bound(size_t count)
{
    return (cohsm__blocks_bound(count) + 2) / 2 + COHSM__BLOCK_WORDS * cohsm__blocks_bound(count);
}

/* Writes a list of two or more segments into zeroed words as the builder keeps it: 16-bit count of blocks and first
   views of all but the first, padded to a word, then the blocks. Returns the words taken. The blocks are written behind
   the longest possible beginning first, and then moved to the end of the real one. */
static size_t cohsm__write_list(uint32_t *words, const cohsm__segment *s, size_t count, const cohsm__grid *grid,
                                uint32_t views)
{
    size_t i, blocks = 0, gap = (cohsm__blocks_bound(count) + 2) / 2, used = 0, directory;
    cohsm__plan p;

    for (i = 0; i < count; i += p.n, blocks++) {
        p = cohsm__plan_block(s + i, count - i, grid, views);
        if (blocks) cohsm__put_bits(words, 16u * (uint32_t)blocks, 16, s[i].first);
        cohsm__write_block(words + gap + used, s + i, &p, grid);
        used += i + p.n < count ? (uint32_t)COHSM__BLOCK_WORDS : (p.size + 31u) / 32u;
    }
    cohsm__put_bits(words, 0, 16, (uint32_t)blocks);
    directory = (blocks + 1) / 2;
    memmove(words + directory, words + gap, 4 * used);
    memset(words + directory + used, 0, 4 * (gap - directory));
    return directory + used;
}

/* ---- >>layout: blocks to lines ---- */

/* Lists come in order of chunk and pixel, whoever made them, and always get the same places: a dry run with NULL
   pointers counts, a second one writes. Tails go where they fit best among a few lines that are still open. */

enum { COHSM__OPEN_LINES = 16 };

typedef struct cohsm__layout {
    uint32_t *directories, *lines;      /* NULL: count only */
    uint64_t  directory_words, line_count;
    uint64_t  open[COHSM__OPEN_LINES];
    uint32_t  used[COHSM__OPEN_LINES];  /* words; 0: no line */
} cohsm__layout;

/* A line with room for a tail, near enough to the next list; a new one where there is none. */
static int cohsm__open_line(cohsm__layout *l, uint32_t words)
{
    int i, best = -1, oldest = 0;
    for (i = 0; i < COHSM__OPEN_LINES; i++) {
        if (l->used[i] && l->line_count - l->open[i] > COHSM__FARTHEST_TAIL) l->used[i] = 0;
        if (l->used[i] && l->used[i] + words <= COHSM__BLOCK_WORDS && (best < 0 || l->used[i] > l->used[best]))
            best = i;
    }
    if (best >= 0) return best;
    for (i = 1; i < COHSM__OPEN_LINES; i++)         /* an unused place, else the fullest line gives way */
        if (l->used[oldest] && (!l->used[i] || l->used[i] > l->used[oldest])) oldest = i;
    l->open[oldest] = l->line_count++;
    l->used[oldest] = 0;
    return oldest;
}

static void cohsm__lay_list(cohsm__layout *l, uint32_t *lookup, uint32_t count, const uint32_t *firsts,
                            uint32_t firsts_at, const uint32_t *full, const uint32_t *tail)
{
    uint32_t words = cohsm__block_words(tail), b, *directory;
    int open = cohsm__open_line(l, words);
    uint64_t base = l->line_count;

    if (l->lines) {
        *lookup = (uint32_t)l->directory_words;
        directory = l->directories + l->directory_words;
        directory[0] = (uint32_t)base;
        directory[1] = count | l->used[open] << 16 | (uint32_t)(base - l->open[open]) << 20;
        for (b = 1; b < count; b++)
            cohsm__put_bits(directory, 16u * (b + 3u), 16, cohsm__half_word(firsts, firsts_at + b));
        memcpy(l->lines + COHSM__BLOCK_WORDS * base, full, 4 * (size_t)COHSM__BLOCK_WORDS * (count - 1u));
        memcpy(l->lines + COHSM__BLOCK_WORDS * l->open[open] + l->used[open], tail, 4 * (size_t)words);
    }
    l->used[open] += words;
    if (l->used[open] + 3u > COHSM__BLOCK_WORDS) l->used[open] = 0;     /* no block is shorter than 3 words */
    l->line_count += count - 1u;
    l->directory_words += 2u + count / 2u;
}

static void cohsm__lay_raw(cohsm__layout *l, uint32_t *lookup, const uint32_t *list)
{
    uint32_t count = list[0] & 0xffffu;
    const uint32_t *full = list + (count + 1u) / 2u;
    cohsm__lay_list(l, lookup, count, list, 0, full, full + COHSM__BLOCK_WORDS * (size_t)(count - 1u));
}

/* ---- >>builder: layers to segments, one view at a time ---- */

enum { COHSM__RANGES = 16, COHSM__BATCH = 32 };

typedef struct cohsm__record {          /* a closed segment on its way to a list */
    uint32_t pixel;                     /* within the range; top bit: exact, its depth in lo | hi << 8 */
    uint16_t first;
    uint8_t  lo, hi;
} cohsm__record;
#define COHSM__EXACT 0x80000000u

typedef struct cohsm__page { struct cohsm__page *next; uint32_t count; cohsm__record records[1]; } cohsm__page;

typedef struct cohsm__range {           /* neighbouring pixels, compressed by one task */
    uint32_t     begin, end;            /* pixels of the shard */
    cohsm__page *first, *last, *spare;  /* log of the chunk; spare: taken from the allocator between tasks */
    uint32_t     next_view;             /* of the batch */
    int          starved;               /* stopped for want of a page */
    uint64_t     segments, exact, empty, open;
} cohsm__range;

typedef struct cohsm__words { struct cohsm__words *next; size_t count; uint32_t data[1]; } cohsm__words;

struct cohsm_builder {
    cohsm__heap       heap;
    cohsm_desc        desc;             /* defaults filled in */
    cohsm__header     head;
    cohsm__parallel   parallel;
    uint32_t         *cells;            /* place in the sequence -> cell */
    float            *locations, *angles;
    uint16_t         *leave;            /* Z1Z3_SPHERE, directions: depth where each pixel's ray leaves the sphere */
    uint8_t          *lo, *hi;          /* the open segment of each pixel of the shard: what grid values it can have */
    uint32_t         *first;            /* its first view within the chunk */
    uint16_t         *batch;            /* COHSM__BATCH views: keep values a pixel, z1 z2 z3 and the depth
                                           where the ray leaves the sphere (Z1Z3_SPHERE only) */
    uint32_t          keep, batch_size, batch_begin, batch_count;
    uint32_t          next_view, range_pixels, page_records;
    cohsm__grid       grid;
    float             thickness;        /* desc.open_thickness in 16-bit depths; of the depth, for positions */
    cohsm__range      ranges[COHSM__RANGES];
    cohsm__words     *lists, *lists_last;
    uint32_t         *lookup;           /* words from the beginning of its piece of lists, until finish */
    size_t            list_words;
    int               finished;         /* or failed: it can only be destroyed */
};

/* Grid value i stands for the depth floor(i 65535 / grid): the least i whose depth is at least d, and the greatest
   whose depth is at most d. */
static uint32_t cohsm__grid_above(uint32_t d, uint32_t grid) { return (d * grid + 65534u) / 65535u; }
static uint32_t cohsm__grid_below(uint32_t d, uint32_t grid) { return ((d + 1u) * grid - 1u) / 65535u; }

/* flag 0: the depth is on the grid. Right before the second layer it would let that layer be lit under a bias of one
   pixel, so it stays two pixels away from it where more than four are left for the first. */
static void cohsm__close_segment(cohsm_builder *b, cohsm__range *r, uint32_t pixel, uint32_t flag, uint32_t lo,
                                 uint32_t hi)
{
    cohsm__record *c = &r->last->records[r->last->count++];
    uint32_t clear = b->head.positional ? 4u * hi / b->head.map_size + 1u : b->grid.margin;
    if (!flag && hi < b->grid.top) hi = hi > lo + 3u * clear ? hi - clear : cohsm__min_u32(hi, lo + 2u * clear);
    c->pixel = (pixel - r->begin) | flag;
    c->first = (uint16_t)b->first[pixel];
    c->lo = (uint8_t)lo;
    c->hi = (uint8_t)hi;
    r->segments++;
}

/* A page with room for what one view can close: two segments a pixel, one before and one of an exact depth. */
static int cohsm__page_ready(const cohsm_builder *b, cohsm__range *r)
{
    cohsm__page *p = r->last;
    if (p && p->count + 2 * (r->end - r->begin) <= b->page_records) return 1;
    if (!r->spare) return 0;
    p = r->spare;
    r->spare = NULL;
    p->next = NULL;
    p->count = 0;
    if (r->last) r->last->next = p;
    else r->first = p;
    r->last = p;
    return 1;
}

/* The interval [lo, hi] that a stored depth must lie in: from the first hit to just before the layer that bounds it.
   1 where that layer lies at the first hit: then z = z1, and the query's bias is trusted. */
static int cohsm__interval(const cohsm_builder *b, const uint16_t *z, uint32_t *lo, uint32_t *hi)
{
    uint32_t z2 = z[1], upper;

    *lo = z[0];
    *hi = COHSM__INFINITE;
    if (z[0] == COHSM__INFINITE) {
        if (b->desc.self_only) *lo = 0;
        return 0;
    }
    if (b->desc.layers == COHSM_LAYERS_Z1Z2) {
        upper = z2;
        if (z2 == COHSM__INFINITE)
            upper = z[0] + 1u + (uint32_t)(b->head.positional ? b->thickness * (float)z[0] : b->thickness);
    } else if (z[2] != COHSM__INFINITE) upper = z[2];
    else if (b->desc.layers == COHSM_LAYERS_Z1Z3_FAR) return 0;
    else upper = cohsm__max_u32(z[3], z2 == COHSM__INFINITE ? z[0] : z2) + 1u;
    *hi = upper > z[0] ? cohsm__min_u32(upper - 1u, COHSM__OPEN) : z[0];
    return upper <= z[0];
}

/* Greedy: a segment goes on as long as one grid value separates the layers of all its views (equation 1).
   No sequence of segments is shorter: any part of a segment that can be stored can be stored too, so by induction the
   greedy segments end no earlier than those of any other sequence. A view that no grid value separates is a segment of
   its own, and stored exactly, in every sequence. */
static void cohsm__compress_view(cohsm_builder *b, cohsm__range *r, const uint16_t *z, uint32_t view)
{
    uint32_t p, lo, hi, glo, ghi, nlo, nhi, depth;

    for (p = r->begin, z += (size_t)p * b->keep; p < r->end; p++, z += b->keep) {
        r->empty += (uint64_t)cohsm__interval(b, z, &lo, &hi);
        glo = cohsm__grid_above(lo, b->grid.top);
        ghi = cohsm__grid_below(hi, b->grid.top);
        nlo = cohsm__max_u32(b->lo[p], glo);
        nhi = cohsm__min_u32(b->hi[p], ghi);
        r->open += z[0] != COHSM__INFINITE && z[1] == COHSM__INFINITE;
        if (nlo > nhi) {
            if (b->first[p] != view) cohsm__close_segment(b, r, p, 0, b->lo[p], b->hi[p]);
            b->first[p] = view;
            nlo = glo;
            nhi = ghi;
            if (glo > ghi) {
                depth = (lo + hi) / 2u;
                cohsm__close_segment(b, r, p, COHSM__EXACT, depth & 255u, depth >> 8);
                r->exact++;
                b->first[p] = view + 1u;
                nlo = 0;
                nhi = b->grid.top;
            }
        }
        b->lo[p] = (uint8_t)nlo;
        b->hi[p] = (uint8_t)nhi;
    }
}

static void cohsm__compress_task(void *context, size_t index)
{
    cohsm_builder *b = (cohsm_builder *)context;
    cohsm__range *r = &b->ranges[index];
    uint32_t chunk_begin = b->batch_begin & ~(COHSM__CHUNK - 1u);

    if (r->begin == r->end) return;                 /* fewer pixels than ranges */
    for (; r->next_view < b->batch_count; r->next_view++) {
        r->starved = !cohsm__page_ready(b, r);
        if (r->starved) return;
        cohsm__compress_view(b, r,
                             b->batch + (size_t)r->next_view * b->batch_size + (size_t)b->desc.pixel_begin * b->keep,
                             b->batch_begin + r->next_view - chunk_begin);
    }
}

static size_t cohsm__page_size(const cohsm_builder *b)
{
    return sizeof(cohsm__page) + (size_t)b->page_records * sizeof(cohsm__record);
}

/* A spare page for each range. Allocation happens here, between tasks, since the caller's allocator need not be safe to
   call from several threads. */
static cohsm_result cohsm__take_spares(cohsm_builder *b)
{
    int i;
    for (i = 0; i < COHSM__RANGES; i++) {
        cohsm__range *r = &b->ranges[i];
        if (r->spare || r->begin == r->end) continue;
        r->spare = (cohsm__page *)cohsm__take(&b->heap, 1, cohsm__page_size(b));
        if (!r->spare) return COHSM_ERR_ALLOC;
        r->spare->next = NULL;
    }
    return COHSM_OK;
}

static cohsm_result cohsm__compress_batch(cohsm_builder *b)
{
    int i, starved;

    for (i = 0; i < COHSM__RANGES; i++) b->ranges[i].next_view = 0;
    do {
        if (cohsm__take_spares(b) != COHSM_OK) return COHSM_ERR_ALLOC;
        cohsm__run(&b->parallel, COHSM__RANGES, cohsm__compress_task, b);
        for (i = 0, starved = 0; i < COHSM__RANGES; i++) starved |= b->ranges[i].starved;
    } while (starved);
    return COHSM_OK;
}

static void cohsm__free_pages(cohsm_builder *b, cohsm__page *p)
{
    while (p) {
        cohsm__page *next = p->next;
        cohsm__give(&b->heap, p, 1, cohsm__page_size(b));
        p = next;
    }
}

static cohsm__segment cohsm__segment_of(const cohsm__record *c)
{
    cohsm__segment s;
    s.exact = (c->pixel & COHSM__EXACT) != 0;
    s.first = c->first;
    s.lo = s.exact ? (uint16_t)((uint32_t)c->lo | (uint32_t)c->hi << 8) : (uint16_t)c->lo;
    s.hi = c->hi;
    return s;
}

static uint32_t cohsm__constant(const cohsm__segment *s, const cohsm__grid *grid)
{
    uint32_t value = grid->top;
    if (s->exact) return COHSM__CONSTANT | s->lo;
    if (s->lo < grid->top) value = cohsm__choose(grid, s->lo, cohsm__min_u32(s->hi, grid->top - 1u));
    return COHSM__CONSTANT | value * 65535u / grid->top;
}

/* Lists of one range: its log sorted by pixel (views are in order already), then written one after the other. */
static cohsm_result cohsm__write_range(cohsm_builder *b, cohsm__range *r, uint32_t *lookup, uint32_t views)
{
    uint32_t pixels = r->end - r->begin, p, i;
    size_t total = 0, bound = 0, used = 0, n;
    size_t *at = (size_t *)cohsm__take(&b->heap, (size_t)pixels + 1, sizeof *at);
    cohsm__segment *segments = NULL;
    cohsm__words *words = NULL, *exact;
    cohsm__page *page;

    if (!at) return COHSM_ERR_ALLOC;
    memset(at, 0, ((size_t)pixels + 1) * sizeof *at);
    for (page = r->first; page; page = page->next)
        for (i = 0; i < page->count; i++) at[page->records[i].pixel & ~COHSM__EXACT]++;
    for (p = 0; p < pixels; p++) {                  /* from counts to ends, walked down to beginnings below */
        bound += at[p] > 1 ? cohsm__list_bound(at[p]) : 0;
        total += at[p];
        at[p] = total - at[p];
    }
    at[pixels] = total;
    segments = (cohsm__segment *)cohsm__take(&b->heap, total, sizeof *segments);
    words = (cohsm__words *)cohsm__take(&b->heap, 1, sizeof *words + 4 * bound);
    if (segments && words) {
        for (page = r->first; page; page = page->next)
            for (i = 0; i < page->count; i++)
                segments[at[page->records[i].pixel & ~COHSM__EXACT]++] = cohsm__segment_of(&page->records[i]);
        memset(words->data, 0, 4 * bound);
        for (p = 0, n = 0; p < pixels; n = at[p++]) {   /* at[p] is the end of list p by now */
            if (at[p] - n == 1) {
                lookup[p] = cohsm__constant(segments + n, &b->grid);
                continue;
            }
            lookup[p] = (uint32_t)used;
            used += cohsm__write_list(words->data + used, segments + n, at[p] - n, &b->grid, views);
        }
        exact = (cohsm__words *)cohsm__take(&b->heap, 1, sizeof *exact + 4 * used);
        if (exact) {
            exact->next = NULL;
            exact->count = used;
            memcpy(exact->data, words->data, 4 * used);
            if (b->lists_last) b->lists_last->next = exact;
            else b->lists = exact;
            b->lists_last = exact;
            b->list_words += used;
        }
    } else exact = NULL;
    cohsm__give(&b->heap, words, 1, sizeof *words + 4 * bound);
    cohsm__give(&b->heap, segments, total, sizeof *segments);
    cohsm__give(&b->heap, at, (size_t)pixels + 1, sizeof *at);
    return exact ? COHSM_OK : COHSM_ERR_ALLOC;
}

/* A chunk of views is complete: closes every segment and turns the log into lists. */
static cohsm_result cohsm__close_chunk(cohsm_builder *b)
{
    uint32_t chunk = (b->next_view - 1u) >> COHSM__CHUNK_BITS, views = ((b->next_view - 1u) & (COHSM__CHUNK - 1u)) + 1u;
    uint32_t *lookup = b->lookup + (size_t)chunk * b->range_pixels, p;
    cohsm_result result = cohsm__take_spares(b);
    int i;

    for (i = 0; i < COHSM__RANGES && result == COHSM_OK; i++) {
        cohsm__range *r = &b->ranges[i];
        if (r->begin == r->end) continue;
        cohsm__page_ready(b, r);
        for (p = r->begin; p < r->end; p++) {
            if (b->first[p] != views) cohsm__close_segment(b, r, p, 0, b->lo[p], b->hi[p]);
            b->first[p] = 0;
            b->lo[p] = 0;
            b->hi[p] = (uint8_t)b->grid.top;
        }
        result = cohsm__write_range(b, r, lookup + r->begin, views);
        cohsm__free_pages(b, r->first);
        r->first = r->last = NULL;
    }
    return result;
}

/* ---- >>desc: checked, with defaults filled in ---- */

static int cohsm__finite3(const float *p) { return cohsm__v3_finite(cohsm__v3_load(p)); }

static int cohsm__check_sides(cohsm_domain *d)
{
    uint32_t *s = d->side, dims, i, fallback;
    uint64_t n = 1;

    if (d->kind == COHSM_DOMAIN_LIST) {
        if (d->location_count == 0 || d->location_count > 1u << 24) return 0;
        s[0] = (uint32_t)d->location_count;
        s[1] = s[2] = 1;
        return 1;
    }
    if (d->kind == COHSM_DOMAIN_TABLE)
        for (i = 0; i < 3; i++) s[i] = s[i] ? s[i] : 1u;
    dims = cohsm__dimensions(d->kind, s);
    fallback = dims == 3 ? 32u : 128u;
    for (i = 0; i < 3; i++) {
        if (i >= dims && s[i] > 1) return 0;
        if (!s[i]) s[i] = i < dims ? fallback : 1u;
        if (s[i] > 4096 && d->kind != COHSM_DOMAIN_TABLE) return 0;
        n *= s[i];
        if (n > 1u << 24) return 0;
    }
    if (d->kind == COHSM_DOMAIN_OCTAHEDRAL && s[0] != s[1]) return 0;
    return d->kind != COHSM_DOMAIN_TABLE || d->location_count == n;
}

static int cohsm__check_shape(const cohsm_domain *d)
{
    cohsm__v3 u = cohsm__v3_load(d->u), v = cohsm__v3_load(d->v), w = cohsm__v3_load(d->w);
    const float *p = d->locations;
    size_t i;

    if (cohsm__has_table((uint32_t)d->kind)) {
        if (!p) return 0;
        for (i = 0; i < d->location_count; i++, p += 4) {
            if (!cohsm__finite3(p) || (p[3] != 0.0f && p[3] != 1.0f) || p[3] != d->locations[3]) return 0;
            if (p[3] == 0.0f && cohsm__v3_length(cohsm__v3_normalize(cohsm__v3_load(p))) == 0.0f) return 0;
        }
        return 1;
    }
    if (d->kind == COHSM_DOMAIN_LATLONG || d->kind == COHSM_DOMAIN_OCTAHEDRAL) return 1;
    if (!cohsm__finite3(d->origin) || !cohsm__finite3(d->u) || !cohsm__finite3(d->v) || !cohsm__finite3(d->w)) return 0;
    if (!(cohsm__v3_length(u) > 0.0f)) return 0;
    if (d->kind == COHSM_DOMAIN_RECTANGLE || d->kind == COHSM_DOMAIN_DISC)
        return cohsm__v3_length(cohsm__v3_cross(u, v)) > 0.0f;
    return d->kind != COHSM_DOMAIN_VOLUME || fabsf(cohsm__v3_dot(cohsm__v3_cross(u, v), w)) > 0.0f;
}

/* Fills in defaults; order and the sphere may stay open until the mesh is known. */
static cohsm_result cohsm__check_desc(cohsm_desc *d)
{
    uint32_t pixels;

    if (!cohsm__allocator_valid(d->allocator.alloc_fn, d->allocator.free_fn)) return COHSM_ERR_DESC;
    if ((unsigned)d->domain.kind >= COHSM_DOMAIN_KIND_COUNT || (unsigned)d->layers >= COHSM_LAYERS_COUNT ||
        (unsigned)d->order >= COHSM_ORDER_COUNT || (unsigned)d->frame >= COHSM_FRAME_COUNT)
        return COHSM_ERR_DESC;
    if (d->domain.kind == COHSM_DOMAIN_DEFAULT) d->domain.kind = COHSM_DOMAIN_LATLONG;
    if (d->layers == COHSM_LAYERS_DEFAULT) d->layers = COHSM_LAYERS_Z1Z2;
    if (!d->map_size) d->map_size = 128;
    if (!d->depth_bits) d->depth_bits = 8;
    if (!(d->open_thickness >= 0.0f)) return COHSM_ERR_DESC;
    if (d->open_thickness == 0.0f) d->open_thickness = 8.0f;
    if (d->open_thickness > (float)d->map_size) d->open_thickness = (float)d->map_size;
    if (d->map_size < 4 || d->map_size > 1024 || d->depth_bits < 4 || d->depth_bits > 8) return COHSM_ERR_DESC;
    if (!cohsm__check_sides(&d->domain) || !cohsm__check_shape(&d->domain)) return COHSM_ERR_DESC;
    if (d->domain.kind == COHSM_DOMAIN_LIST || d->domain.kind == COHSM_DOMAIN_LINE) d->order = COHSM_ORDER_SCANLINE;
    if (!cohsm__finite3(d->center) || !cohsm__finite(d->radius) || d->radius < 0.0f) return COHSM_ERR_DESC;
    pixels = d->map_size * d->map_size;
    if (!d->pixel_begin && !d->pixel_end) d->pixel_end = pixels;
    return d->pixel_begin < d->pixel_end && d->pixel_end <= pixels ? COHSM_OK : COHSM_ERR_DESC;
}

/* Far enough from the ends of the float range for squares and inverses. */
static int cohsm__radius_usable(float r) { return r > 1e-18f && r < 1e18f; }

static int cohsm__is_positional(const cohsm_domain *d)
{
    if (cohsm__has_table((uint32_t)d->kind)) return d->locations[3] != 0.0f;
    return d->kind != COHSM_DOMAIN_LATLONG && d->kind != COHSM_DOMAIN_OCTAHEDRAL;
}

static void cohsm__fill_header(cohsm__header *h, const cohsm_desc *d)
{
    memset(h, 0, sizeof *h);
    h->magic = COHSM__MAGIC;
    h->format = COHSM__FORMAT;
    h->domain = (uint32_t)d->domain.kind;
    h->layers = (uint32_t)d->layers;
    h->order = (uint32_t)d->order;
    h->frame = (uint32_t)d->frame;
    memcpy(h->side, d->domain.side, sizeof h->side);
    h->map_count = h->side[0] * h->side[1] * h->side[2];
    h->positional = (uint32_t)cohsm__is_positional(&d->domain);
    h->view_count = h->map_count * (h->positional ? 6u : 1u);
    h->map_size = d->map_size;
    h->depth_bits = d->depth_bits;
    h->open_thickness = d->open_thickness;
    h->dimensions = cohsm__dimensions(d->domain.kind, h->side);
    h->self_only = d->self_only != 0;
    h->pixel_begin = d->pixel_begin;
    h->pixel_end = d->pixel_end;
    if (d->order == COHSM_ORDER_HILBERT) h->order_words = h->map_count <= 65536 ? (h->map_count + 1) / 2 : h->map_count;
    if (cohsm__has_table(h->domain)) h->location_words = 4 * h->map_count;
    memcpy(h->center, d->center, sizeof h->center);
    h->radius = d->radius;
    if (!cohsm__has_table(h->domain) && h->positional) {
        memcpy(h->origin, d->domain.origin, sizeof h->origin);
        memcpy(h->u, d->domain.u, sizeof h->u);
        memcpy(h->v, d->domain.v, sizeof h->v);
        memcpy(h->w, d->domain.w, sizeof h->w);
    }
}

static uint32_t cohsm__chunks(const cohsm__header *h) { return (h->view_count - 1u) / COHSM__CHUNK + 1u; }

/* Depth 1 of positional maps: as far as anything of the object is from any location. */
static float cohsm__far_distance(const cohsm__header *h, const float *locations)
{
    cohsm__v3 c = cohsm__v3_load(h->center);
    float farthest = 0.0f, d;
    uint32_t i;
    for (i = 0; i < h->map_count; i++) {
        d = cohsm__v3_length(cohsm__v3_sub(cohsm__cell_location(h, locations, i), c));
        if (d > farthest) farthest = d;
    }
    return (farthest + h->radius) * 1.0001f;
}

static cohsm__camera cohsm__camera_of(const cohsm__header *h, const float *locations, const float *angles,
                                      uint32_t cell, uint32_t face)
{
    cohsm__camera cam;
    memset(&cam, 0, sizeof cam);
    cam.perspective = h->positional != 0;
    if (cam.perspective) {
        cam.face = face;
        cam.eye = cohsm__v3_sub(cohsm__cell_location(h, locations, cell), cohsm__v3_load(h->center));
        cam.eye = cohsm__v3_scale(cam.eye, 1.0f / h->radius);
        cam.depth_scale = h->radius / h->depth_far;
    } else cam.frame = cohsm__cell_frame(h, locations, angles, cell);
    return cam;
}

/* Depth at which the ray through a pixel's centre leaves the bounding sphere. */
static uint16_t cohsm__leave_depth(const cohsm__camera *cam, uint32_t size, uint32_t pixel)
{
    float x = ((float)(pixel % size) + 0.5f) / (float)size * 2.0f - 1.0f;
    float y = ((float)(pixel / size) + 0.5f) / (float)size * 2.0f - 1.0f, a, b, c, disc;
    cohsm__v3 e = cam->eye;
    float ex, ey, ew;

    if (!cam->perspective) {
        disc = 1.0f - x * x - y * y;
        return cohsm__depth16(0.5f + 0.5f * sqrtf(disc > 0.0f ? disc : 0.0f));
    }
    cohsm__face_coordinates(cam->face, e, &ex, &ey, &ew);
    a = x * x + y * y + 1.0f;
    b = ex * x + ey * y + ew;
    c = ex * ex + ey * ey + ew * ew - 1.0f;
    disc = b * b - a * c;
    if (!(disc > 0.0f)) return 0;
    return cohsm__depth16((sqrtf(disc) - b) / a * cam->depth_scale);
}

/* ---- >>builder: public ---- */

COHSM_DEF void cohsm_builder_free(cohsm_builder *b)
{
    cohsm__words *w, *next;
    cohsm__heap heap;
    uint32_t n;
    int i;

    if (!b) return;
    n = b->range_pixels;
    for (w = b->lists; w; w = next) {
        next = w->next;
        cohsm__give(&b->heap, w, 1, sizeof *w + 4 * w->count);
    }
    for (i = 0; i < COHSM__RANGES; i++) {
        cohsm__free_pages(b, b->ranges[i].first);
        cohsm__free_pages(b, b->ranges[i].spare);
    }
    cohsm__give(&b->heap, b->batch, (size_t)b->batch_size * COHSM__BATCH, sizeof *b->batch);
    cohsm__give(&b->heap, b->lookup, (size_t)n * cohsm__chunks(&b->head), sizeof *b->lookup);
    cohsm__give(&b->heap, b->first, n, sizeof *b->first);
    cohsm__give(&b->heap, b->hi, n, 1);
    cohsm__give(&b->heap, b->lo, n, 1);
    cohsm__give(&b->heap, b->angles, 2 * ((size_t)b->head.side[0] + b->head.side[1]), sizeof(float));
    cohsm__give(&b->heap, b->locations, b->head.location_words, sizeof(float));
    cohsm__give(&b->heap, b->cells, b->head.map_count, sizeof *b->cells);
    heap = b->heap;
    cohsm__give(&heap, b, 1, sizeof *b);
}

/* The header's table of locations: directions made unit length. One that is so but for rounding stays: the desc of a
   built block must give the same rays again. */
static void cohsm__copy_locations(float *out, const cohsm_domain *d)
{
    size_t i;
    for (i = 0; i < d->location_count; i++) {
        cohsm__v3 p = cohsm__v3_load(d->locations + 4 * i);
        if (d->locations[3] == 0.0f && fabsf(cohsm__v3_dot(p, p) - 1.0f) > 1e-6f) p = cohsm__v3_normalize(p);
        cohsm__v3_store(out + 4 * i, p);
        out[4 * i + 3] = d->locations[3];
    }
}

static void cohsm__split_ranges(cohsm_builder *b)
{
    uint32_t n = b->range_pixels, i, widest = (n + COHSM__RANGES - 1) / COHSM__RANGES;
    for (i = 0; i < COHSM__RANGES; i++) {
        b->ranges[i].begin = (uint32_t)((uint64_t)n * i / COHSM__RANGES);
        b->ranges[i].end = (uint32_t)((uint64_t)n * (i + 1) / COHSM__RANGES);
    }
    b->page_records = cohsm__max_u32(4 * widest, 256);
}

/* Locations so far away that distances overflow leave something that is not finite here. */
static int cohsm__floats_finite(const cohsm__header *h)
{
    const float *f;
    for (f = h->center; f < h->dop + 2 * COHSM__DOP_AXES; f++)
        if (!cohsm__finite(*f)) return 0;
    return 1;
}

static void cohsm__drop_builder(cohsm_builder *b, cohsm__heap *heap)
{
    heap->peak = b->heap.peak;
    heap->used -= sizeof *b;
    cohsm_builder_free(b);
}

/* desc is checked and complete. On success the builder's heap takes over what heap had counted. */
static cohsm_result cohsm__builder_make(const cohsm_desc *desc, cohsm__heap *heap, cohsm_builder **out)
{
    cohsm_builder *b = (cohsm_builder *)cohsm__take(heap, 1, sizeof *b);
    uint32_t n = desc->pixel_end - desc->pixel_begin;
    size_t lookup;

    if (!b) return COHSM_ERR_ALLOC;
    memset(b, 0, sizeof *b);
    b->desc = *desc;
    cohsm__fill_header(&b->head, desc);
    b->heap = *heap;
    b->parallel.run = desc->parallel_for;
    b->parallel.user = desc->parallel_user;
    b->range_pixels = n;
    b->grid = cohsm__grid_of(desc->depth_bits, desc->map_size);
    b->thickness = desc->open_thickness * (b->head.positional ? 2.0f : 65536.0f) / (float)desc->map_size;
    b->keep = desc->layers == COHSM_LAYERS_Z1Z2 ? 2 : 4;
    b->batch_size = desc->map_size * desc->map_size * b->keep;
    if (!cohsm__mul_size(n, cohsm__chunks(&b->head), &lookup) || lookup > UINT32_MAX / 4) {
        cohsm__give(heap, b, 1, sizeof *b);
        return COHSM_ERR_LIMIT;
    }
    b->cells = (uint32_t *)cohsm__take(&b->heap, b->head.map_count, sizeof *b->cells);
    b->angles = (float *)cohsm__take(&b->heap, 2 * ((size_t)b->head.side[0] + b->head.side[1]), sizeof(float));
    if (b->head.location_words)
        b->locations = (float *)cohsm__take(&b->heap, b->head.location_words, sizeof(float));
    b->lo = (uint8_t *)cohsm__take(&b->heap, n, 1);
    b->hi = (uint8_t *)cohsm__take(&b->heap, n, 1);
    b->first = (uint32_t *)cohsm__take(&b->heap, n, sizeof *b->first);
    b->lookup = (uint32_t *)cohsm__take(&b->heap, lookup, sizeof *b->lookup);
    b->batch = (uint16_t *)cohsm__take(&b->heap, (size_t)b->batch_size * COHSM__BATCH, sizeof *b->batch);
    cohsm__split_ranges(b);
    if (!b->cells || !b->angles || (b->head.location_words && !b->locations) || !b->lo || !b->hi || !b->first ||
        !b->lookup || !b->batch) {
        cohsm__drop_builder(b, heap);
        return COHSM_ERR_ALLOC;
    }
    memset(b->lo, 0, n);
    memset(b->hi, (int)b->grid.top, n);
    memset(b->first, 0, n * sizeof *b->first);
    memset(b->lookup, 0, lookup * sizeof *b->lookup);
    cohsm__order_cells(b->cells, b->head.side, desc->order);
    if (b->locations) cohsm__copy_locations(b->locations, &desc->domain);
    cohsm__latlong_angles(b->head.side, b->angles);
    cohsm__dop_of_sphere(b->head.dop, b->head.center, b->head.radius);
    if (b->head.positional) b->head.depth_far = cohsm__far_distance(&b->head, b->locations);
    if (!cohsm__floats_finite(&b->head)) {
        cohsm__drop_builder(b, heap);
        return COHSM_ERR_DESC;
    }
    *out = b;
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_builder_create(const cohsm_desc *desc, cohsm_builder **out)
{
    cohsm_desc d;
    cohsm__heap heap;
    cohsm_result result;

    if (!desc || !out) return COHSM_ERR_ARGUMENT;
    d = *desc;
    result = cohsm__check_desc(&d);
    if (result != COHSM_OK) return result;
    if (!cohsm__radius_usable(d.radius)) return COHSM_ERR_DESC;
    if (d.order == COHSM_ORDER_DEFAULT) d.order = COHSM_ORDER_HILBERT;
    if (d.frame == COHSM_FRAME_DEFAULT) d.frame = COHSM_FRAME_POLAR;
    memset(&heap, 0, sizeof heap);
    heap.allocator = cohsm__allocator_make(d.allocator.alloc_fn, d.allocator.free_fn, d.allocator.user);
    return cohsm__builder_make(&d, &heap, out);
}

COHSM_DEF uint32_t cohsm_builder_view_count(const cohsm_builder *b) { return b ? b->head.view_count : 0; }

static void cohsm__put_row(float *m, int row, cohsm__v3 v, float w)
{
    m[row] = v.x;
    m[row + 4] = v.y;
    m[row + 8] = v.z;
    m[row + 12] = w;
}

static void cohsm__view_matrix(const cohsm__header *h, const cohsm__camera *cam, cohsm__v3 location, float *m)
{
    float half = 0.5f * (float)h->map_size, scale = half / h->radius;
    cohsm__v3 c = cohsm__v3_load(h->center), axis[3], x, y, w;
    int i = (int)(cam->face >> 1);

    memset(m, 0, 16 * sizeof *m);
    m[15] = 1.0f;
    if (!cam->perspective) {
        cohsm__put_row(m, 0, cohsm__v3_scale(cam->frame.right, scale),
                       half - scale * cohsm__v3_dot(cam->frame.right, c));
        cohsm__put_row(m, 1, cohsm__v3_scale(cam->frame.up, scale), half - scale * cohsm__v3_dot(cam->frame.up, c));
        cohsm__put_row(m, 2, cohsm__v3_scale(cam->frame.back, -0.5f / h->radius),
                       0.5f + 0.5f / h->radius * cohsm__v3_dot(cam->frame.back, c));
        return;
    }
    axis[0] = cohsm__v3_make(1, 0, 0);
    axis[1] = cohsm__v3_make(0, 1, 0);
    axis[2] = cohsm__v3_make(0, 0, 1);
    w = cohsm__v3_scale(axis[i], cam->face & 1u ? -1.0f : 1.0f);
    x = cohsm__v3_scale(cohsm__v3_add(axis[(i + 1) % 3], w), half);
    y = cohsm__v3_scale(cohsm__v3_add(axis[(i + 2) % 3], w), half);
    cohsm__put_row(m, 0, x, -cohsm__v3_dot(x, location));
    cohsm__put_row(m, 1, y, -cohsm__v3_dot(y, location));
    cohsm__put_row(m, 3, w, -cohsm__v3_dot(w, location));
}

COHSM_DEF cohsm_result cohsm_builder_view(const cohsm_builder *b, uint32_t index, cohsm_view *out)
{
    cohsm__camera cam;
    cohsm__v3 location;
    uint32_t cell;

    if (!b || !out || index >= b->head.view_count) return COHSM_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    cell = b->cells[index % b->head.map_count];
    location = cohsm__cell_location(&b->head, b->locations, cell);
    out->index = index;
    out->cell = cell;
    out->face = index / b->head.map_count;
    cohsm__v3_store(out->location, location);
    out->location[3] = b->head.positional ? 1.0f : 0.0f;
    cam = cohsm__camera_of(&b->head, b->locations, b->angles, cell, out->face);
    if (cam.perspective) out->depth_scale = 1.0f / b->head.depth_far;
    cohsm__view_matrix(&b->head, &cam, location, out->matrix);
    return COHSM_OK;
}

static cohsm_result cohsm__close_batch(cohsm_builder *b)
{
    cohsm_result result = cohsm__compress_batch(b);
    b->next_view = b->batch_begin + b->batch_count;
    b->batch_begin = b->next_view;
    b->batch_count = 0;
    if (result == COHSM_OK && (b->next_view % COHSM__CHUNK == 0 || b->next_view == b->head.view_count))
        result = cohsm__close_chunk(b);
    b->finished = result != COHSM_OK;
    return result;
}

/* 16-bit layers of the shard's pixels. */
static void cohsm__take_layers(const cohsm_builder *b, uint16_t *z, const float *z1, const float *z2, const float *z3)
{
    const float *layer[3];
    cohsm__camera cam = cohsm__camera_of(&b->head, b->locations, b->angles,
                                         b->cells[b->next_view % b->head.map_count], b->next_view / b->head.map_count);
    uint32_t p, pixel, i;

    layer[0] = z1;
    layer[1] = z2;
    layer[2] = z3;
    for (p = 0; p < b->range_pixels; p++) {
        pixel = b->desc.pixel_begin + p;
        for (i = 0; i < (b->keep == 4 ? 3u : 2u); i++)
            z[pixel * b->keep + i] =
                layer[i][pixel] <= 1.0f ? cohsm__depth16(layer[i][pixel]) : (uint16_t)COHSM__INFINITE;
        if (b->keep == 4) z[pixel * b->keep + 3] = cohsm__leave_depth(&cam, b->head.map_size, pixel);
    }
}

COHSM_DEF cohsm_result cohsm_builder_add(cohsm_builder *b, uint32_t index, const float *z1, const float *z2,
                                         const float *z3)
{
    uint32_t i, pixels;

    if (!b || !z1 || !z2 || (b->keep == 4 && !z3)) return COHSM_ERR_ARGUMENT;
    if (b->finished || index != b->batch_begin + b->batch_count || index >= b->head.view_count) return COHSM_ERR_ORDER;
    pixels = b->head.map_size * b->head.map_size;
    for (i = 0; i < pixels; i++)
        if (!(z1[i] <= z2[i]) || (b->keep == 4 && !(z2[i] <= z3[i]))) return COHSM_ERR_INPUT;
    b->next_view = index;
    cohsm__take_layers(b, b->batch + (size_t)b->batch_size * b->batch_count, z1, z2, z3);
    b->batch_count++;
    if (b->batch_count < COHSM__BATCH && index + 1 < b->head.view_count) return COHSM_OK;
    return cohsm__close_batch(b);
}

/* ---- >>block: the finished maps ---- */

static void cohsm__host_words(uint32_t *words, size_t count)
{
    size_t i;
    if (cohsm__host_is_little_endian()) return;
    for (i = 0; i < count; i++) words[i] = cohsm__get_u32((const uint8_t *)(words + i));
}

static void cohsm__crc_words(const uint32_t *words, size_t count, uint32_t *crc)
{
    uint8_t bytes[256];
    size_t i, n;
    if (cohsm__host_is_little_endian()) {
        *crc = cohsm__crc32(*crc, words, 4 * count);
        return;
    }
    for (; count; count -= n, words += n) {
        n = count < 64 ? count : 64;
        for (i = 0; i < n; i++) cohsm__put_u32(bytes + 4 * i, words[i]);
        *crc = cohsm__crc32(*crc, bytes, 4 * n);
    }
}

static uint32_t cohsm__block_crc(const uint32_t *words, size_t count)
{
    uint32_t crc = 0;
    cohsm__crc_words(words + 4, count - 4, &crc);
    return crc;
}

/* Sections of a block whose header is sound. */
static void cohsm__point(cohsm_maps *m)
{
    const uint32_t *at = m->words + COHSM__HEADER_WORDS;
    uint32_t i, grid = (1u << m->head.depth_bits) - 1u;

    m->order = at;
    at += m->head.order_words;
    m->locations = (const float *)(const void *)at;
    at += m->head.location_words;
    m->lookup = at;
    at += m->head.lookup_words;
    m->directories = at;
    at += m->head.directory_words;
    m->lines = at;
    m->range = m->head.pixel_end - m->head.pixel_begin;
    for (i = 0; i < 512; i++) m->depth_of[i] = (uint16_t)(i < grid ? i * 65535u / grid : (uint32_t)COHSM__INFINITE);
    for (i = 0; i < 2 * COHSM__DOP_AXES; i++)
        m->dop[i] = (m->head.dop[i] - cohsm__v3_dot(cohsm__dop_axis((int)(i / 2)), cohsm__v3_load(m->head.center))) /
                    m->head.radius;
    m->simd = cohsm__simd();
    if (m->angles) cohsm__latlong_angles(m->head.side, m->angles);
}

/* Zeroed words at a cache line's boundary; the allocator promises 8 bytes only. */
typedef struct cohsm__memory { void *memory; uint32_t *words; } cohsm__memory;

static cohsm__memory cohsm__take_block(const cohsm__allocator *a, uint32_t words)
{
    cohsm__memory b;
    size_t size;

    b.memory = b.words = NULL;
    if (!cohsm__mul_size(words, 4, &size) || !cohsm__add_size(size, 64, &size)) return b;   /* 32-bit targets */
    b.memory = cohsm__alloc(a, size);
    if (!b.memory) return b;
    b.words = (uint32_t *)(void *)((char *)b.memory + (64u - (uintptr_t)b.memory % 64u));
    memset(b.words, 0, 4 * (size_t)words);
    return b;
}

/* An object for a block in host order whose header is sound. Takes the memory over, or frees it where it fails. */
static cohsm_result cohsm__maps_make(const cohsm__allocator *a, cohsm__memory block, cohsm_maps **out)
{
    cohsm_maps *m = (cohsm_maps *)cohsm__alloc(a, sizeof *m);
    if (m) {
        memset(m, 0, sizeof *m);
        m->allocator = *a;
        m->memory = block.memory;
        m->words = block.words;
        memcpy(&m->head, block.words, sizeof m->head);
        if (m->head.domain == COHSM_DOMAIN_LATLONG) {
            m->angles = (float *)cohsm__alloc_array(a, 2 * ((size_t)m->head.side[0] + m->head.side[1]), sizeof(float));
            if (!m->angles) {
                cohsm__free(a, m);
                m = NULL;
            }
        }
    }
    if (!m) {
        cohsm__free(a, block.memory);
        return COHSM_ERR_ALLOC;
    }
    cohsm__point(m);
    *out = m;
    return COHSM_OK;
}

COHSM_DEF void cohsm_free(cohsm_maps *maps)
{
    cohsm__allocator a;
    if (!maps) return;
    a = maps->allocator;
    cohsm__free(&a, maps->angles);
    cohsm__free(&a, maps->memory);
    cohsm__free(&a, maps);
}

static void cohsm__write_order(uint32_t *words, const uint32_t *cells, uint32_t count)
{
    uint32_t i;
    for (i = 0; i < count; i++)
        if (count <= 65536) cohsm__put_bits(words, 16 * cells[i], 16, i);
        else words[cells[i]] = i;
}

/* All lists of a builder. lookup: where each list begins in its piece, replaced by where its directory is. */
static void cohsm__lay_builder(const cohsm_builder *b, cohsm__layout *l, uint32_t *lookup)
{
    const cohsm__words *piece = b->lists;
    uint32_t c, i, p, chunks = cohsm__chunks(&b->head);

    for (c = 0; c < chunks; c++, lookup += b->range_pixels)
        for (i = 0; i < COHSM__RANGES; i++) {
            const cohsm__range *r = &b->ranges[i];
            if (r->begin == r->end) continue;
            for (p = r->begin; p < r->end; p++)
                if (!(lookup[p] & COHSM__CONSTANT)) cohsm__lay_raw(l, lookup + p, piece->data + lookup[p]);
            piece = piece->next;
        }
}

/* Lengths of the last sections, from a dry run of the layout. */
static cohsm_result cohsm__size_block(cohsm__header *h, const cohsm__layout *l)
{
    uint64_t before = (uint64_t)COHSM__HEADER_WORDS + h->order_words + h->location_words + h->lookup_words;
    uint64_t directories = l->directory_words, lines = COHSM__BLOCK_WORDS * l->line_count + COHSM__PADDING;
    directories += (0u - (before + directories)) % COHSM__BLOCK_WORDS;
    if (before + directories + lines > 0x3fffffffu) return COHSM_ERR_LIMIT;
    h->directory_words = (uint32_t)directories;
    h->line_words = (uint32_t)lines;
    h->words = (uint32_t)(before + directories + lines);
    return COHSM_OK;
}

static void cohsm__layout_into(cohsm__layout *l, const cohsm__header *h, uint32_t *words, uint32_t **lookup)
{
    memset(l, 0, sizeof *l);
    *lookup = words + COHSM__HEADER_WORDS + h->order_words + h->location_words;
    l->directories = *lookup + h->lookup_words;
    l->lines = l->directories + h->directory_words;
}

static void cohsm__seal(uint32_t *words, const cohsm__header *h)
{
    memcpy(words, h, sizeof *h);
    words[3] = cohsm__block_crc(words, h->words);
}

/* words[] is zeroed and as long as the header says. */
static void cohsm__assemble(const cohsm_builder *b, uint32_t *words)
{
    const cohsm__header *h = &b->head;
    cohsm__layout layout;
    uint32_t *lookup;

    cohsm__layout_into(&layout, h, words, &lookup);
    if (h->order_words) cohsm__write_order(words + COHSM__HEADER_WORDS, b->cells, h->map_count);
    if (h->location_words)
        memcpy(words + COHSM__HEADER_WORDS + h->order_words, b->locations, 4 * (size_t)h->location_words);
    memcpy(lookup, b->lookup, 4 * (size_t)h->lookup_words);
    cohsm__lay_builder(b, &layout, lookup);
    cohsm__seal(words, h);
}

static void cohsm__sum_stats(const cohsm_builder *b, cohsm_stats *s)
{
    int i;
    for (i = 0; i < COHSM__RANGES; i++) {
        s->segments += b->ranges[i].segments;
        s->exact_depths += b->ranges[i].exact;
        s->empty_intervals += b->ranges[i].empty;
        s->open_entries += b->ranges[i].open;
    }
    s->order = (cohsm_order)b->head.order;
    s->peak_bytes = b->heap.peak;
}

/* Every field of stats but the mesh's. */
static cohsm_result cohsm__finish(cohsm_builder *b, cohsm_maps **out, cohsm_stats *stats)
{
    cohsm__header *h = &b->head;
    cohsm__layout dry;
    cohsm__memory block;
    cohsm_result result;

    memset(&dry, 0, sizeof dry);
    cohsm__sum_stats(b, stats);
    h->lookup_words = b->range_pixels * cohsm__chunks(h);
    h->segments_low = (uint32_t)(stats->segments & 0xffffffffu);
    h->segments_high = (uint32_t)(stats->segments >> 32);
    cohsm__lay_builder(b, &dry, b->lookup);
    result = cohsm__size_block(h, &dry);
    if (result != COHSM_OK) return result;
    stats->peak_bytes = b->heap.used + 4 * (size_t)h->words + 64 + sizeof(cohsm_maps) +
                        8 * ((size_t)h->side[0] + h->side[1]) * (h->domain == COHSM_DOMAIN_LATLONG);
    if (stats->peak_bytes < b->heap.peak) stats->peak_bytes = b->heap.peak;
    block = cohsm__take_block(&b->heap.allocator, h->words);
    if (!block.words) return COHSM_ERR_ALLOC;
    cohsm__assemble(b, block.words);
    return cohsm__maps_make(&b->heap.allocator, block, out);
}

COHSM_DEF cohsm_result cohsm_builder_finish(cohsm_builder *b, cohsm_maps **out, cohsm_stats *stats)
{
    cohsm_stats s;
    cohsm_result result;

    if (!b || !out) return COHSM_ERR_ARGUMENT;
    if (b->finished || b->next_view != b->head.view_count || b->batch_count) return COHSM_ERR_ORDER;
    memset(&s, 0, sizeof s);
    result = cohsm__finish(b, out, &s);
    if (result != COHSM_OK) return result;
    b->finished = 1;
    if (stats) *stats = s;
    return COHSM_OK;
}

/* ---- >>build: from a mesh ---- */

typedef struct cohsm__job { cohsm_builder *builder; const cohsm__soup *soup; int simd; } cohsm__job;

static void cohsm__raster_task(void *context, size_t index)
{
    const cohsm__job *job = (const cohsm__job *)context;
    const cohsm_builder *b = job->builder;
    uint32_t view = b->batch_begin + (uint32_t)index, m = b->head.map_size, p;
    cohsm__camera cam = cohsm__camera_of(&b->head, b->locations, b->angles, b->cells[view % b->head.map_count],
                                         view / b->head.map_count);
    cohsm__target target;

    target.z = b->batch + index * b->batch_size;
    target.keep = b->keep;
    target.size = (int)m;
    target.row_begin = (int)(b->desc.pixel_begin / m);
    target.row_end = (int)((b->desc.pixel_end + m - 1u) / m);
    cohsm__raster(&target, &cam, job->soup, job->simd);
    if (b->desc.layers == COHSM_LAYERS_Z1Z3_SPHERE)
        for (p = b->desc.pixel_begin; p < b->desc.pixel_end; p++)
            target.z[4 * (size_t)p + 3] = cohsm__leave_depth(&cam, m, p);
}

static cohsm_result cohsm__build_views(cohsm_builder *b, const cohsm__soup *soup)
{
    cohsm__job job;
    cohsm_result result = COHSM_OK;

    job.builder = b;
    job.soup = soup;
    job.simd = cohsm__simd();
    while (result == COHSM_OK && b->next_view < b->head.view_count) {
        if (b->desc.progress &&
            b->desc.progress(b->desc.progress_user, (float)b->next_view / (float)b->head.view_count))
            return COHSM_ERR_CANCELLED;
        b->batch_count = cohsm__min_u32(COHSM__BATCH, b->head.view_count - b->next_view);
        cohsm__run(&b->parallel, b->batch_count, cohsm__raster_task, &job);
        result = cohsm__close_batch(b);
    }
    return result;
}

/* A mesh made ready: sphere, k-DOP and soup; desc gets the sphere. */
typedef struct cohsm__model { cohsm__soup soup; float dop[2 * COHSM__DOP_AXES]; } cohsm__model;

static cohsm_result cohsm__model_bound(cohsm__model *model, cohsm_desc *d, const cohsm__points *points)
{
    if (!(d->radius > 0.0f)) cohsm__fit_sphere(points, d->center, &d->radius);
    else if (!cohsm__sphere_holds(points, d->center, d->radius)) return COHSM_ERR_DESC;
    if (!cohsm__radius_usable(d->radius)) return COHSM_ERR_INPUT;
    cohsm__dop_of_points(model->dop, points);
    return COHSM_OK;
}

static cohsm_result cohsm__model_make(cohsm__model *model, cohsm_desc *d, const cohsm_mesh *mesh, cohsm__heap *heap,
                                      cohsm_stats *stats)
{
    size_t count;
    uint8_t *used;
    cohsm__points points;
    cohsm_result result = cohsm__check_mesh(mesh);

    if (result != COHSM_OK) return result;
    count = cohsm__triangle_count(mesh);
    used = (uint8_t *)cohsm__take(heap, count, 1);
    if (!used) return COHSM_ERR_ALLOC;
    result = cohsm__select(mesh, used, heap, stats);
    if (result == COHSM_OK) {
        result = cohsm__points_make(&points, mesh, used, stats->triangles, heap) ? cohsm__model_bound(model, d, &points)
                                                                                 : COHSM_ERR_ALLOC;
        cohsm__points_free(&points, heap);
    }
    if (result == COHSM_OK &&
        !cohsm__soup_make(&model->soup, mesh, used, stats->triangles, d->center, d->radius, heap))
        result = COHSM_ERR_ALLOC;
    cohsm__give(heap, used, count, 1);
    return result;
}

static cohsm_result cohsm__build_model(const cohsm_desc *d, const cohsm__model *model, cohsm__heap *heap,
                                       cohsm_maps **out, cohsm_stats *stats)
{
    cohsm_builder *b;
    cohsm_result result = cohsm__builder_make(d, heap, &b);

    if (result != COHSM_OK) return result;
    memcpy(b->head.dop, model->dop, sizeof model->dop);
    result = cohsm__build_views(b, &model->soup);
    if (result == COHSM_OK) result = cohsm__finish(b, out, stats);
    cohsm__drop_builder(b, heap);
    return result;
}

static void cohsm__take_part(cohsm_desc *d, cohsm__part *p, float from, float to)
{
    p->progress = d->progress;
    p->user = d->progress_user;
    p->from = from;
    p->to = to;
    if (!d->progress) return;
    d->progress = cohsm__part_progress;
    d->progress_user = p;
}

/* Segments of a build with sides divided by shrink and half the map size. */
static cohsm_result cohsm__try_small(const cohsm_desc *d, const cohsm__model *model, uint32_t shrink, cohsm__heap *heap,
                                     double *segments)
{
    cohsm_desc trial = *d;
    cohsm__part part;
    cohsm_maps *maps;
    cohsm_stats stats;
    cohsm_result result;
    int i;

    memset(&stats, 0, sizeof stats);
    cohsm__take_part(&trial, &part, 0.0f, 0.0f);
    for (i = 0; i < 3; i++) trial.domain.side[i] = (d->domain.side[i] + shrink - 1u) / shrink;
    trial.map_size = cohsm__max_u32(d->map_size / 2, 8);
    trial.pixel_begin = 0;
    trial.pixel_end = trial.map_size * trial.map_size;
    result = cohsm__build_model(&trial, model, heap, &maps, &stats);
    if (result != COHSM_OK) return result;
    cohsm_free(maps);
    *segments = (double)stats.segments;
    return COHSM_OK;
}

/* Order and frame, where the desc leaves them open: tried at a quarter and an eighth of each side and continued by that
   growth for two more doublings, since zig-zag is ahead of Hilbert on few maps and falls behind on many. Below 8 maps a
   side such growth says little, so that small domains are tried at a half, or whole. */
static cohsm_result cohsm__choose_sequence(cohsm_desc *d, const cohsm__model *model, cohsm__heap *heap)
{
    static const cohsm_order orders[2] = { COHSM_ORDER_HILBERT, COHSM_ORDER_ZIGZAG_THETA };
    static const cohsm_frame frames[2] = { COHSM_FRAME_POLAR, COHSM_FRAME_TWO_POLES };
    int tabled = cohsm__has_table((uint32_t)d->domain.kind), o, f;
    int any_order = d->order == COHSM_ORDER_DEFAULT && !tabled;
    int any_frame = d->frame == COHSM_FRAME_DEFAULT && !tabled && !cohsm__is_positional(&d->domain);
    uint32_t shrink = d->domain.side[0] >= 32 ? 4 : d->domain.side[0] >= 16 ? 2 : 1, k;
    double least = 0.0, segments = 0.0, growth;
    cohsm_desc trial = *d;
    cohsm_result result;

    if (d->order == COHSM_ORDER_DEFAULT) d->order = COHSM_ORDER_HILBERT;
    if (d->frame == COHSM_FRAME_DEFAULT) d->frame = COHSM_FRAME_POLAR;
    if (!any_order && !any_frame) return COHSM_OK;
    for (o = 0; o < (any_order ? 2 : 1); o++)
        for (f = 0; f < (any_frame ? 2 : 1); f++) {
            trial.order = any_order ? orders[o] : d->order;
            trial.frame = any_frame ? frames[f] : d->frame;
            result = cohsm__try_small(&trial, model, shrink, heap, &segments);
            growth = segments;
            if (result == COHSM_OK && shrink > 1) result = cohsm__try_small(&trial, model, 2 * shrink, heap, &growth);
            if (result != COHSM_OK) return result;
            growth = segments / growth;                              /* by one doubling */
            for (k = shrink; k > 1; k /= 2) segments *= growth;
            if (least == 0.0 || segments < least) {
                least = segments;
                d->order = any_order ? orders[o] : d->order;
                d->frame = any_frame ? frames[f] : d->frame;
            }
        }
    return COHSM_OK;
}

/* Bytes a pixel, and the cells' own, of a build with this side; from, to: of the progress. */
static cohsm_result cohsm__try_side(cohsm_desc d, const cohsm_mesh *mesh, uint32_t side, float from, float to,
                                    double *per_pixel)
{
    cohsm__part part;
    cohsm_maps *maps;
    cohsm_result result;

    cohsm__take_part(&d, &part, from, to);
    d.domain.side[0] = d.domain.side[1] = side;
    d.map_size = 64;
    d.pixel_begin = d.pixel_end = 0;
    result = cohsm_build(&d, mesh, &maps, NULL);
    if (result != COHSM_OK) return result;
    *per_pixel =
        (double)(maps->head.lookup_words + maps->head.directory_words + maps->head.line_words) * 4.0 / (64 * 64);
    cohsm_free(maps);
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_budget(const cohsm_desc *desc, const cohsm_mesh *mesh, size_t bytes, uint32_t *side,
                                    uint32_t *map_size)
{
    cohsm_desc d;
    double coarse, fine, pixel, error, least = 0.0, growth;
    uint32_t n, m, step, maps;
    cohsm_result result;

    if (!mesh || !side || !map_size) return COHSM_ERR_ARGUMENT;
    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    if (d.domain.kind != COHSM_DOMAIN_DEFAULT && d.domain.kind != COHSM_DOMAIN_LATLONG &&
        d.domain.kind != COHSM_DOMAIN_OCTAHEDRAL)
        return COHSM_ERR_DOMAIN;
    if (d.order == COHSM_ORDER_DEFAULT) d.order = COHSM_ORDER_HILBERT;
    result = cohsm__try_side(d, mesh, 16, 0.0f, 0.2f, &coarse);
    if (result == COHSM_OK) result = cohsm__try_side(d, mesh, 32, 0.2f, 1.0f, &fine);
    if (result != COHSM_OK) return result;
    growth = fine / coarse > 1.0 ? fine / coarse : 1.0;
    for (n = 8, pixel = coarse / growth; n <= 2048; n *= 2, pixel *= growth)     /* n, and 1.5 n half a doubling on */
        for (step = 2; step <= 3; step++)
            for (m = 16, maps = (n * step / 2u) * (n * step / 2u); m <= 1024; m += 16) {
                double size = pixel * (step == 3 ? 0.5 * (1.0 + growth) : 1.0) * m * m;
                size += 4.0 * (double)COHSM__HEADER_WORDS + (maps > 65536u ? 4.0 : 2.0) * maps;
                size += 4.0 * m * m * ((maps - 1u) / 65536u);   /* lookup of every chunk but the first, in pixel */
                if (size > 0.9 * (double)bytes) break;
                error = 0.0055 * 128.0 / (n * step / 2u) + 0.0185 * sqrt(128.0 / m);
                if (least > 0.0 && error >= least) continue;
                least = error;
                *side = n * step / 2u;
                *map_size = m;
            }
    return least > 0.0 ? COHSM_OK : COHSM_ERR_LIMIT;
}

COHSM_DEF cohsm_result cohsm_build(const cohsm_desc *desc, const cohsm_mesh *mesh, cohsm_maps **out, cohsm_stats *stats)
{
    cohsm_desc d;
    cohsm_stats s;
    cohsm__heap heap;
    cohsm__model model;
    cohsm_result result;

    if (!mesh || !out) return COHSM_ERR_ARGUMENT;
    memset(&d, 0, sizeof d);
    memset(&s, 0, sizeof s);
    memset(&heap, 0, sizeof heap);
    memset(&model, 0, sizeof model);
    if (desc) d = *desc;
    result = cohsm__check_desc(&d);
    if (result != COHSM_OK) return result;
    heap.allocator = cohsm__allocator_make(d.allocator.alloc_fn, d.allocator.free_fn, d.allocator.user);
    result = cohsm__model_make(&model, &d, mesh, &heap, &s);
    if (result == COHSM_OK) result = cohsm__choose_sequence(&d, &model, &heap);
    if (result == COHSM_OK) result = cohsm__build_model(&d, &model, &heap, out, &s);
    cohsm__soup_free(&model.soup, &heap);
    if (result == COHSM_OK && stats) *stats = s;
    return result;
}

/* ---- >>facts ---- */

COHSM_DEF const char *cohsm_result_text(cohsm_result result)
{
    switch (result) {
#define COHSM__TEXT(name, text) case name: return text;
    COHSM_RESULTS(COHSM__TEXT)
#undef COHSM__TEXT
    default: return "unknown result";
    }
}

COHSM_DEF void cohsm_get_info(const cohsm_maps *m, cohsm_info *out)
{
    const cohsm__header *h;
    if (!m || !out) return;
    h = &m->head;
    memset(out, 0, sizeof *out);
    out->domain = (cohsm_domain_kind)h->domain;
    out->layers = (cohsm_layers)h->layers;
    out->order = (cohsm_order)h->order;
    out->frame = (cohsm_frame)h->frame;
    memcpy(out->side, h->side, sizeof out->side);
    out->map_count = h->map_count;
    out->view_count = h->view_count;
    out->map_size = h->map_size;
    out->depth_bits = h->depth_bits;
    out->dimensions = h->dimensions;
    out->positional = (int)h->positional;
    out->self_only = (int)h->self_only;
    out->pixel_begin = h->pixel_begin;
    out->pixel_end = h->pixel_end;
    memcpy(out->center, h->center, sizeof out->center);
    out->radius = h->radius;
    out->depth_far = h->depth_far;
    out->segments = (uint64_t)h->segments_high << 32 | h->segments_low;
    out->bytes = 4 * (size_t)h->words;
    out->ratio = 2.0 * (double)h->view_count * (double)m->range / (double)out->bytes;
}

COHSM_DEF cohsm_result cohsm_location(const cohsm_maps *m, uint32_t map, float out[4])
{
    if (!m || !out || map >= m->head.map_count) return COHSM_ERR_ARGUMENT;
    cohsm__v3_store(out, cohsm__cell_location(&m->head, m->locations, map));
    out[3] = m->head.positional ? 1.0f : 0.0f;
    return COHSM_OK;
}

COHSM_DEF const void *cohsm_data(const cohsm_maps *m, size_t *size)
{
    if (!m) return NULL;
    if (size) *size = 4 * (size_t)m->head.words;
    return m->words;
}

COHSM_DEF cohsm_result cohsm_write(const cohsm_maps *m, void *memory, size_t memory_size)
{
    uint32_t i;
    if (!m || !memory) return COHSM_ERR_ARGUMENT;
    if (memory_size < 4 * (size_t)m->head.words) return COHSM_ERR_MEMORY;
    for (i = 0; i < m->head.words; i++) cohsm__put_u32((uint8_t *)memory + 4 * (size_t)i, m->words[i]);
    return COHSM_OK;
}

static uint32_t cohsm__place(const cohsm_maps *m, uint32_t x, uint32_t y, uint32_t z)
{
    const uint32_t *s = m->head.side;
    uint32_t line, cell;
    switch (m->head.order) {
    case COHSM_ORDER_ZIGZAG:
        line = (z & 1u ? s[1] - 1u - y : y) + s[1] * z;
        return line * s[0] + (line & 1u ? s[0] - 1u - x : x);
    case COHSM_ORDER_ZIGZAG_THETA:
        line = (z & 1u ? s[0] - 1u - x : x) + s[0] * z;
        return line * s[1] + (line & 1u ? s[1] - 1u - y : y);
    case COHSM_ORDER_HILBERT:
        cell = x + s[0] * (y + s[1] * z);
        return m->head.map_count <= 65536 ? cohsm__half_word(m->order, cell) : m->order[cell];
    default: return x + s[0] * (y + s[1] * z);
    }
}

COHSM_DEF cohsm_result cohsm_depths(const cohsm_maps *m, uint32_t view, uint16_t *out)
{
    uint32_t c[3], p, place;
    if (!m || !out || view >= m->head.view_count) return COHSM_ERR_ARGUMENT;
    cohsm__cell_split(m->head.side, view % m->head.map_count, c);
    place = view / m->head.map_count * m->head.map_count + cohsm__place(m, c[0], c[1], c[2]);
    for (p = 0; p < m->range; p++)
        out[p] = (uint16_t)cohsm__stored_depth(m, p, place);
    return COHSM_OK;
}

/* ---- >>query ---- */

/* Samples are treated in tiles: first every sample's map, pixel and depth, then the searches in steps that each begin
   by prefetching what the next needs, so that cache misses overlap. */

enum { COHSM__TILE = 256, COHSM__KEPT = 512 };   /* kept: by 4 bits of x and 5 of y, for M = 128 */
#define COHSM__NO_PIXEL UINT32_MAX      /* outside the map, or not finite: lit */

#if defined(__GNUC__) && !defined(__TINYC__)
#define COHSM__PREFETCH(p) __builtin_prefetch(p)
#define COHSM__FLATTEN __attribute__((flatten))
#else
#define COHSM__PREFETCH(p) ((void)(p))
#define COHSM__FLATTEN
#endif

typedef struct cohsm__tile {            /* one object's samples, in its space */
    const cohsm_maps  *maps;
    const cohsm_query *query;
    uint32_t seed;                      /* roulette's: each instance draws its own, else products have another mean */
    size_t   count;
    int      one_light;                 /* light[.][0] is everyone's */
    float    point[3][COHSM__TILE];     /* in radii about the sphere's centre */
    float    light[3][COHSM__TILE];     /* direction; position in radii; or parameters */
    uint32_t cell[COHSM__TILE];         /* COHSM_LIGHT_INDEX */
    size_t   id[COHSM__TILE];           /* number in the query */
    float    visible[COHSM__TILE];
    uint32_t pixel[COHSM__TILE], place[COHSM__TILE];
    int32_t  depth[COHSM__TILE];
    uint32_t kept_pixel[COHSM__KEPT], kept_depth[COHSM__KEPT];     /* one light: depths decoded for earlier samples */
    uint8_t  wanted[COHSM__KEPT];
} cohsm__tile;

static void cohsm__tile_start(cohsm__tile *t, const cohsm_query *q, const cohsm_maps *maps, uint32_t instance)
{
    t->maps = maps;
    t->query = q;
    t->seed = q->seed + 0x9e3779b9u * instance;
    t->one_light = q->one_light;
    t->count = 0;
    if (!q->one_light) return;
    memset(t->kept_pixel, 0xff, sizeof t->kept_pixel);
    memset(t->kept_depth, 0, sizeof t->kept_depth);
    memset(t->wanted, 0, sizeof t->wanted);
}

/* Continuous position in the domain: cell units, cell centres at whole numbers. */
static void cohsm__domain_position(const cohsm_maps *m, cohsm__v3 l, cohsm_light kind, float f[3])
{
    const uint32_t *s = m->head.side;
    float u[3];
    int i;

    u[0] = l.x;
    u[1] = l.y;
    u[2] = l.z;
    if (kind == COHSM_LIGHT_DIRECTION || kind == COHSM_LIGHT_POSITION) {
        if (m->head.domain == COHSM_DOMAIN_LATLONG) {
            u[0] = 0.5f + cohsm__atan2(l.z, l.x) * 0.159154943f;
            u[1] = cohsm__acos(l.y / cohsm__v3_length(l)) * 0.318309886f;
        } else cohsm__octa_square(cohsm__v3_normalize(l), u, u + 1);
    }
    for (i = 0; i < 3; i++) {
        float top = (float)s[i];
        f[i] = i < (int)m->head.dimensions ? u[i] * top : 0.0f;
        if (!(f[i] >= 0.0f)) f[i] = 0.0f;
        if (f[i] > top) f[i] = top;
        f[i] -= 0.5f;
    }
}

static int cohsm__floor(float x)
{
    int i = (int)x;
    return (float)i > x ? i - 1 : i;
}

/* Brings a cell one step outside back: around the seam, over a pole, across the edge of the octahedral square, or to
   the border. */
static void cohsm__wrap(const cohsm_maps *m, int *c)
{
    int n0 = (int)m->head.side[0], n1 = (int)m->head.side[1], i;
    uint32_t kind = m->head.domain;

    if (kind == COHSM_DOMAIN_LATLONG || kind == COHSM_DOMAIN_SPHERE) {
        if (c[1] < 0 || c[1] >= n1) c[0] += n0 / 2;
        if (c[0] < 0) c[0] += n0;
        while (c[0] >= n0) c[0] -= n0;
    } else if (kind == COHSM_DOMAIN_OCTAHEDRAL) {
        if (c[0] < 0 || c[0] >= n0) c[1] = n1 - 1 - c[1];
        else if (c[1] < 0 || c[1] >= n1) c[0] = n0 - 1 - c[0];
    }
    for (i = 0; i < 3; i++) {
        if (c[i] < 0) c[i] = 0;
        if (c[i] >= (int)m->head.side[i]) c[i] = (int)m->head.side[i] - 1;
    }
}

static uint32_t cohsm__cell_index(const cohsm_maps *m, const int *c)
{
    return (uint32_t)c[0] + m->head.side[0] * ((uint32_t)c[1] + m->head.side[1] * (uint32_t)c[2]);
}

/* A point seen in one map: position in pixels, depth in 16 bits, and where the six faces of a cube begin. */
typedef struct cohsm__seen { float x, y, depth; uint32_t face; } cohsm__seen;

static cohsm__seen cohsm__see(const cohsm_maps *m, uint32_t cell, cohsm__v3 p, float bias)
{
    float half = 0.5f * (float)m->head.map_size, w;
    cohsm__seen s;
    cohsm__frame f;
    cohsm__v3 q;

    s.face = 0;
    if (!m->head.positional) {
        f = cohsm__cell_frame(&m->head, m->locations, m->angles, cell);
        s.x = cohsm__v3_dot(p, f.right) * half + half;
        s.y = cohsm__v3_dot(p, f.up) * half + half;
        s.depth = (0.5f - 0.5f * cohsm__v3_dot(p, f.back) - bias / (float)m->head.map_size) * (float)COHSM__HIT_MAX;
        return s;
    }
    q = cohsm__v3_sub(cohsm__cell_location(&m->head, m->locations, cell), cohsm__v3_load(m->head.center));
    q = cohsm__v3_sub(p, cohsm__v3_scale(q, 1.0f / m->head.radius));
    s.face = cohsm__face_of(q);
    cohsm__face_coordinates(s.face, q, &s.x, &s.y, &w);
    s.x = s.x / w * half + half;
    s.y = s.y / w * half + half;
    s.depth = w * (1.0f - 2.0f * bias / (float)m->head.map_size) * (m->head.radius / m->head.depth_far) *
              (float)COHSM__HIT_MAX;
    return s;
}

static int32_t cohsm__compared_depth(float depth)
{
    if (!(depth >= 0.0f)) return -1;
    return depth < 65535.0f ? (int32_t)depth : 65535;
}

static uint32_t cohsm__pixel(const cohsm_maps *m, float x, float y)
{
    float top = (float)m->head.map_size;
    uint32_t p;
    if (m->head.positional) {                       /* rounding may leave the face by a hair */
        x = x < 0.0f ? 0.0f : x >= top ? top - 0.5f : x;
        y = y < 0.0f ? 0.0f : y >= top ? top - 0.5f : y;
    }
    if (!(x >= 0.0f && x < top && y >= 0.0f && y < top)) return COHSM__NO_PIXEL;
    p = (uint32_t)y * m->head.map_size + (uint32_t)x;
    return p >= m->head.pixel_begin && p < m->head.pixel_end ? p - m->head.pixel_begin : COHSM__NO_PIXEL;
}

static float cohsm__lit(const cohsm_maps *m, uint32_t pixel, uint32_t place, int32_t depth)
{
    if (pixel == COHSM__NO_PIXEL || depth < 0) return 1.0f;
    return depth > (int32_t)cohsm__stored_depth(m, pixel, place) ? 0.0f : 1.0f;
}

/* Weights of generalised PCF are products of one fraction for each of the d + 2 dimensions (paper 4.5). What is dark is
   summed, so that a sample which nothing shadows is exactly 1. */
static float cohsm__pcf_map(const cohsm_maps *m, const int *c, cohsm__v3 p, float bias)
{
    uint32_t place = cohsm__place(m, (uint32_t)c[0], (uint32_t)c[1], (uint32_t)c[2]), corner;
    cohsm__seen s = cohsm__see(m, cohsm__cell_index(m, c), p, bias);
    float x, y, fx, fy, dark = 0.0f;
    int32_t depth = cohsm__compared_depth(s.depth);

    if (!(fabsf(s.x) < 1e6f && fabsf(s.y) < 1e6f)) return 0.0f;
    place += s.face * m->head.map_count;
    x = (float)cohsm__floor(s.x - 0.5f);
    y = (float)cohsm__floor(s.y - 0.5f);
    fx = s.x - 0.5f - x;
    fy = s.y - 0.5f - y;
    for (corner = 0; corner < 4; corner++) {
        float weight = (corner & 1u ? fx : 1.0f - fx) * (corner & 2u ? fy : 1.0f - fy);
        uint32_t pixel = cohsm__pixel(m, x + (float)(corner & 1u) + 0.5f, y + (float)(corner >> 1) + 0.5f);
        if (weight > 0.0f) dark += weight * (1.0f - cohsm__lit(m, pixel, place, depth));
    }
    return dark;
}

static float cohsm__pcf(const cohsm_maps *m, const float *f, cohsm__v3 p, float bias)
{
    uint32_t d = m->head.dimensions, corner, i;
    float dark = 0.0f;

    for (corner = 0; corner < 1u << d; corner++) {
        float weight = 1.0f;
        int c[3] = { 0, 0, 0 };
        for (i = 0; i < d; i++) {
            int low = cohsm__floor(f[i]);
            float fraction = f[i] - (float)low;
            weight *= corner >> i & 1u ? fraction : 1.0f - fraction;
            c[i] = low + (int)(corner >> i & 1u);
        }
        if (!(weight > 0.0f)) continue;
        cohsm__wrap(m, c);
        dark += weight * cohsm__pcf_map(m, c, p, bias);
    }
    return dark;
}

/* Rounding of the weights may leave a little of either. */
static float cohsm__lit_of(float dark) { return dark >= 0.999999f ? 0.0f : 1.0f - dark; }

static cohsm__v3 cohsm__tile_point(const cohsm__tile *t, size_t i)
{
    return cohsm__v3_make(t->point[0][i], t->point[1][i], t->point[2][i]);
}

static cohsm__v3 cohsm__tile_light(const cohsm__tile *t, size_t i)
{
    if (t->one_light) i = 0;
    return cohsm__v3_make(t->light[0][i], t->light[1][i], t->light[2][i]);
}

/* Roulette is the nearest neighbour of a position moved at random by up to half a step: a fraction f is rounded up with
   probability f, which is its weight in PCF. */
static float cohsm__jitter(const cohsm__tile *t, uint32_t id, uint32_t dimension)
{
    return t->query->filter == COHSM_FILTER_ROULETTE ? cohsm__random(t->seed, id, dimension) : 0.5f;
}

/* A direction whose length can be computed. */
static int cohsm__usable(cohsm__v3 l)
{
    float length = cohsm__v3_length(l);
    return length > 0.0f && length < 3.4e38f;
}

/* Map, pixel and depth of sample i; or its visibility at once, with PCF. */
static void cohsm__address(cohsm__tile *t, size_t i)
{
    const cohsm_maps *m = t->maps;
    const cohsm_query *q = t->query;
    cohsm__v3 p = cohsm__tile_point(t, i), l = cohsm__tile_light(t, i);
    cohsm__seen s;
    float f[3] = { 0, 0, 0 };
    uint32_t k, id = (uint32_t)t->id[i];
    int c[3] = { 0, 0, 0 };

    t->pixel[i] = COHSM__NO_PIXEL;
    if (!cohsm__v3_finite(p) || (q->light != COHSM_LIGHT_INDEX && !cohsm__v3_finite(l))) return;
    if (q->light == COHSM_LIGHT_INDEX) {
        if (t->cell[t->one_light ? 0 : i] >= m->head.map_count) return;     /* unknown, like a light at NaN */
        cohsm__cell_split(m->head.side, t->cell[t->one_light ? 0 : i], (uint32_t *)c);
        if (q->filter == COHSM_FILTER_PCF) {
            t->visible[i] = cohsm__lit_of(cohsm__pcf_map(m, c, p, q->bias));
            return;
        }
    } else {
        if (q->light == COHSM_LIGHT_POSITION) l = cohsm__v3_sub(l, p);
        if (q->light != COHSM_LIGHT_PARAMETER && !cohsm__usable(l)) return;
        cohsm__domain_position(m, l, q->light, f);
        if (q->filter == COHSM_FILTER_PCF) {
            t->visible[i] = cohsm__lit_of(cohsm__pcf(m, f, p, q->bias));
            return;
        }
        for (k = 0; k < m->head.dimensions; k++) c[k] = cohsm__floor(f[k] + cohsm__jitter(t, id, k));
        cohsm__wrap(m, c);
    }
    s = cohsm__see(m, cohsm__cell_index(m, c), p, q->bias);
    if (q->filter == COHSM_FILTER_ROULETTE) {
        s.x += cohsm__jitter(t, id, 3) - 0.5f;
        s.y += cohsm__jitter(t, id, 4) - 0.5f;
    }
    t->depth[i] = cohsm__compared_depth(s.depth);
    if (t->depth[i] < 0) return;
    t->pixel[i] = cohsm__pixel(m, s.x, s.y);
    t->place[i] = cohsm__place(m, (uint32_t)c[0], (uint32_t)c[1], (uint32_t)c[2]) + s.face * m->head.map_count;
}

/* Directions to LATLONG maps, a step of samples at a time: cohsm__address, but in loops of constant length without
   branches or calls, which compilers vectorise at -O2. On x86 they are compiled once more for AVX2.
   Step small enough that what one loop leaves, or prefetches, is still in the first-level cache for the next. */

enum { COHSM__STEP = 64 };

typedef struct cohsm__step {
    float jitter[5][COHSM__STEP];       /* of the cell's two dimensions, -, and the pixel's */
    float at[4][COHSM__STEP];           /* jittered: in the domain, in cells; -, - or in the map, in pixels */
    int32_t cell[2][COHSM__STEP], valid[COHSM__STEP];
    float angle[4][COHSM__STEP];        /* cos phi, sin phi, cos theta, sin theta */
    float right[3][COHSM__STEP], up[3][COHSM__STEP], back[3][COHSM__STEP];
} cohsm__step;

/* sqrtf may set errno, so that compilers do not vectorise it. */
static void cohsm__step_roots(float *x)
{
    int k;
#if COHSM__SIMD && (defined(__SSE2__) || defined(_M_X64))
    for (k = 0; k < COHSM__STEP; k += 4) _mm_storeu_ps(x + k, _mm_sqrt_ps(_mm_loadu_ps(x + k)));
#else
    for (k = 0; k < COHSM__STEP; k++) x[k] = sqrtf(x[k]);
#endif
}

static void cohsm__step_cells(cohsm__step *s, const cohsm__tile *t, size_t first)
{
    const cohsm_maps *m = t->maps;
    const float *x = t->light[0] + first, *y = t->light[1] + first, *z = t->light[2] + first;
    int32_t n0 = (int32_t)m->head.side[0], n1 = (int32_t)m->head.side[1], c0, c1;
    float top0 = (float)n0, top1 = (float)n1, u, v, height[COHSM__STEP], root[COHSM__STEP];
    int k;

    for (k = 0; k < COHSM__STEP; k++) root[k] = x[k] * x[k] + y[k] * y[k] + z[k] * z[k];
    cohsm__step_roots(root);
    for (k = 0; k < COHSM__STEP; k++) {
        s->valid[k] = (root[k] > 0.0f) & (root[k] < 3.4e38f);
        height[k] = y[k] / root[k];
        root[k] = cohsm__acos_square(height[k]);
    }
    cohsm__step_roots(root);
    for (k = 0; k < COHSM__STEP; k++) {
        u = (0.5f + cohsm__atan2(z[k], x[k]) * 0.159154943f) * top0;
        v = cohsm__acos_rooted(height[k], root[k]) * 0.318309886f * top1;
        u = cohsm__either(u >= 0.0f, u, 0.0f);
        v = cohsm__either(v >= 0.0f, v, 0.0f);
        u = cohsm__either(u > top0, top0, u) - 0.5f + s->jitter[0][k];
        v = cohsm__either(v > top1, top1, v) - 0.5f + s->jitter[1][k];
        s->at[0][k] = u;
        s->at[1][k] = v;
        c0 = (int32_t)u;
        c1 = (int32_t)v;
        c0 -= (float)c0 > u;
        c1 -= (float)c1 > v;
        c0 += n0 / 2 & (0 - ((c1 < 0) | (c1 >= n1)));                       /* cohsm__wrap */
        c0 += n0 & (0 - (c0 < 0));
        c0 -= n0 & (0 - (c0 >= n0));
        s->cell[0][k] = c0;
        s->cell[1][k] = c1 + (c1 < 0) - (c1 >= n1);
    }
}

/* cohsm__cell_frame */
static void cohsm__step_frames(cohsm__step *s, const cohsm_maps *m)
{
    const float *columns = m->angles, *rows = m->angles + 2 * m->head.side[0];
    int k, two_poles = m->head.frame == COHSM_FRAME_TWO_POLES;

    for (k = 0; k < COHSM__STEP; k++) {
        s->angle[0][k] = columns[2 * s->cell[0][k]];
        s->angle[1][k] = columns[2 * s->cell[0][k] + 1];
        s->angle[2][k] = rows[2 * s->cell[1][k]];
        s->angle[3][k] = rows[2 * s->cell[1][k] + 1];
    }
    for (k = 0; k < COHSM__STEP; k++) {
        float cp = s->angle[0][k], sp = s->angle[1][k], ct = s->angle[2][k], st = s->angle[3][k];
        s->right[0][k] = -sp;
        s->right[1][k] = 0.0f;
        s->right[2][k] = cp;
        s->up[0][k] = -ct * cp;
        s->up[1][k] = st;
        s->up[2][k] = -ct * sp;
        s->back[0][k] = st * cp;
        s->back[1][k] = ct;
        s->back[2][k] = st * sp;
    }
    if (m->head.frame == COHSM_FRAME_POLAR) return;
    for (k = 0; k < COHSM__STEP; k++) {
        float x = s->back[0][k], y = s->back[1][k], z = s->back[2][k], a, g, odd;
        g = cohsm__either(!two_poles | (y >= 0.0f), 1.0f, -1.0f);
        odd = fabsf(g + y) < 1e-6f ? 1.0f : 0.0f;
        a = -1.0f / (g + y + odd);
        a = odd > 0.0f ? 0.0f : a;
        s->right[0][k] = 1.0f + g * x * x * a;
        s->right[1][k] = odd > 0.0f ? 0.0f : -g * x;
        s->right[2][k] = g * x * z * a;
        s->up[0][k] = x * z * a;
        s->up[1][k] = odd > 0.0f ? 0.0f : -z;
        s->up[2][k] = g + z * z * a;
    }
}

/* cohsm__see, cohsm__pixel and cohsm__compared_depth. Points outside the map, in front of it or not finite get
   COHSM__NO_PIXEL. */
static void cohsm__step_see(cohsm__step *s, cohsm__tile *t, size_t first)
{
    const cohsm_maps *m = t->maps;
    const float *px = t->point[0] + first, *py = t->point[1] + first, *pz = t->point[2] + first;
    float top = (float)m->head.map_size, half = 0.5f * top, bias = t->query->bias / top, x, y, d;
    int32_t side = (int32_t)m->head.map_size, begin = (int32_t)m->head.pixel_begin, end = begin + (int32_t)m->range;
    int32_t in, p;
    int k;

    for (k = 0; k < COHSM__STEP; k++) {
        x = (px[k] * s->right[0][k] + py[k] * s->right[1][k] + pz[k] * s->right[2][k]) * half + half;
        y = (px[k] * s->up[0][k] + py[k] * s->up[1][k] + pz[k] * s->up[2][k]) * half + half;
        d = px[k] * s->back[0][k] + py[k] * s->back[1][k] + pz[k] * s->back[2][k];
        d = (0.5f - 0.5f * d - bias) * (float)COHSM__HIT_MAX;
        x += s->jitter[3][k] - 0.5f;
        y += s->jitter[4][k] - 0.5f;
        s->at[2][k] = x;
        s->at[3][k] = y;
        in = s->valid[k] & (x >= 0.0f) & (x < top) & (y >= 0.0f) & (y < top) & (d >= 0.0f);
        x = in ? x : 0.0f;
        y = in ? y : 0.0f;
        d = in ? d : 0.0f;
        p = (int32_t)y * side + (int32_t)x;
        in &= (p >= begin) & (p < end);
        t->pixel[first + (size_t)k] = in ? (uint32_t)(p - begin) : COHSM__NO_PIXEL;
        t->depth[first + (size_t)k] = (int32_t)(d < 65535.0f ? d : 65535.0f);
    }
}

static void cohsm__step_places(const cohsm__step *s, cohsm__tile *t, size_t first)
{
    const cohsm_maps *m = t->maps;
    uint32_t *place = t->place + first, n0 = m->head.side[0], n1 = m->head.side[1], c0, c1;
    int k;

    if (m->head.order == COHSM_ORDER_HILBERT)
        for (k = 0; k < COHSM__STEP; k++)
            place[k] = cohsm__place(m, (uint32_t)s->cell[0][k], (uint32_t)s->cell[1][k], 0);
    else if (m->head.order == COHSM_ORDER_ZIGZAG_THETA)
        for (k = 0; k < COHSM__STEP; k++) {
            c0 = (uint32_t)s->cell[0][k];
            c1 = (uint32_t)s->cell[1][k];
            place[k] = c0 * n1 + (c0 & 1u ? n1 - 1u - c1 : c1);
        }
    else {
        uint32_t zigzag = m->head.order == COHSM_ORDER_ZIGZAG;
        for (k = 0; k < COHSM__STEP; k++) {
            c0 = (uint32_t)s->cell[0][k];
            c1 = (uint32_t)s->cell[1][k];
            place[k] = c1 * n0 + (c1 & zigzag ? n0 - 1u - c0 : c0);
        }
    }
}

/* NEAREST takes the cell and pixel round a sample; ROULETTE those round it moved at random by up to a half; PCF all
   sixteen round it, one for each corner: bits 0 and 1 in the domain, 2 and 3 in the map. */
static void cohsm__step_jitter(cohsm__step *s, const cohsm__tile *t, size_t first, uint32_t corner)
{
    static const uint32_t dimension[4] = { 0, 1, 3, 4 };
    cohsm_filter filter = t->query->filter;
    float same;
    uint32_t i, d;
    int k;

    for (i = 0; i < 4; i++) {
        d = dimension[i];
        same = filter != COHSM_FILTER_PCF ? 0.5f : corner >> i & 1u ? 1.0f : 0.0f;
        if (filter == COHSM_FILTER_ROULETTE)
            for (k = 0; k < COHSM__STEP; k++)
                s->jitter[d][k] = cohsm__random(t->seed, (uint32_t)t->id[first + (size_t)k], d);
        else for (k = 0; k < COHSM__STEP; k++) s->jitter[d][k] = same;
    }
}

/* weight: where not NULL, by what share each sample lies towards the next cell or pixel, in the dimensions of which the
   corner is the lower one */
static void cohsm__address_latlong(cohsm__tile *t, uint32_t corner, float (*weight)[COHSM__TILE])
{
    cohsm__step s;
    size_t first;
    float x, low;
    int k, i;

    for (first = 0; first < t->count; first += COHSM__STEP) {
        cohsm__step_jitter(&s, t, first, corner);
        cohsm__step_cells(&s, t, first);
        cohsm__step_frames(&s, t->maps);
        cohsm__step_see(&s, t, first);
        cohsm__step_places(&s, t, first);
        for (i = 0; weight && i < 4; i++) {
            if (corner >> i & 1u) continue;
            for (k = 0; k < COHSM__STEP; k++) {
                x = cohsm__either(fabsf(s.at[i][k]) < 1e6f, s.at[i][k], 0.0f);
                low = (float)(int32_t)x;
                weight[i][first + (size_t)k] = x - (low - cohsm__either(low > x, 1.0f, 0.0f));
            }
        }
    }
}

COHSM__FLATTEN static void cohsm__address_portable(cohsm__tile *t, uint32_t corner, float (*weight)[COHSM__TILE])
{
    cohsm__address_latlong(t, corner, weight);
}

static void cohsm__search(cohsm__tile *t)
{
    const cohsm_maps *m = t->maps;
    const uint32_t *at[COHSM__TILE];
    uint32_t n = 0, which[COHSM__TILE], view[COHSM__TILE], i, entry;

    for (i = 0; i < t->count; i++) {
        if (t->pixel[i] == COHSM__NO_PIXEL) continue;
        entry = m->lookup[(size_t)(t->place[i] >> COHSM__CHUNK_BITS) * m->range + t->pixel[i]];
        if (entry & COHSM__CONSTANT) {
            t->visible[i] = t->depth[i] > (int32_t)(entry & 0xffffu) ? 0.0f : 1.0f;
            continue;
        }
        at[n] = m->directories + entry;
        COHSM__PREFETCH(at[n]);
        view[n] = t->place[i] & (COHSM__CHUNK - 1u);
        which[n++] = i;
    }
    for (i = 0; i < n; i++) {
        at[i] = cohsm__list_block(m, at[i], &view[i]);
        COHSM__PREFETCH(at[i]);
    }
    for (i = 0; i < n; i++)
        if (t->depth[which[i]] > (int32_t)cohsm__depth_in_block(m, at[i], view[i])) t->visible[which[i]] = 0.0f;
}

/* Semi-local light: refused inside the hull; and where the ray meets the hull only beyond the light, or not at all, the
   object cannot be in between (T67): one of light or hull must come first, since the light is outside a convex hull. */
static int cohsm__light_refused(const cohsm_maps *m, cohsm__v3 l)
{
    int i;
    for (i = 0; i < COHSM__DOP_AXES; i++) {
        float d = cohsm__v3_dot(cohsm__dop_axis(i), l);
        if (d < m->dop[2 * i] || d > m->dop[2 * i + 1]) return 0;
    }
    return 1;
}

static int cohsm__hull_between(const cohsm_maps *m, cohsm__v3 p, cohsm__v3 l)
{
    float enter = 0.0f, leave = 1.0f;
    int i;
    for (i = 0; i < COHSM__DOP_AXES; i++) {
        cohsm__v3 a = cohsm__dop_axis(i);
        float from = cohsm__v3_dot(a, p), step = cohsm__v3_dot(a, l) - from, t0, t1;
        if (step == 0.0f) {
            if (from < m->dop[2 * i] || from > m->dop[2 * i + 1]) return 0;
            continue;
        }
        t0 = (m->dop[2 * i] - from) / step;
        t1 = (m->dop[2 * i + 1] - from) / step;
        if (t0 > t1) {
            float swap = t0;
            t0 = t1;
            t1 = swap;
        }
        if (t0 > enter) enter = t0;
        if (t1 < leave) leave = t1;
    }
    return enter <= leave;
}

/* One direction for all points: one frame. Returns the place of the map. */
static uint32_t cohsm__one_frame(const cohsm_maps *m, cohsm__v3 direction, cohsm__frame *f)
{
    int c[3] = { 0, 0, 0 };
    float u[3];

    cohsm__domain_position(m, direction, COHSM_LIGHT_DIRECTION, u);
    c[0] = cohsm__floor(u[0] + 0.5f);
    c[1] = cohsm__floor(u[1] + 0.5f);
    cohsm__wrap(m, c);
    *f = cohsm__cell_frame(&m->head, m->locations, m->angles, cohsm__cell_index(m, c));
    return cohsm__place(m, (uint32_t)c[0], (uint32_t)c[1], 0);
}

static inline uint32_t cohsm__see_all(cohsm__tile *t)
{
    cohsm__step s;
    cohsm__frame f;
    uint32_t place = cohsm__one_frame(t->maps, cohsm__tile_light(t, 0), &f);
    size_t first;
    int k;

    for (k = 0; k < COHSM__STEP; k++) {
        s.right[0][k] = f.right.x;
        s.right[1][k] = f.right.y;
        s.right[2][k] = f.right.z;
        s.up[0][k] = f.up.x;
        s.up[1][k] = f.up.y;
        s.up[2][k] = f.up.z;
        s.back[0][k] = f.back.x;
        s.back[1][k] = f.back.y;
        s.back[2][k] = f.back.z;
        s.jitter[3][k] = s.jitter[4][k] = 0.5f;
        s.valid[k] = 1;
    }
    for (first = 0; first < t->count; first += COHSM__STEP) cohsm__step_see(&s, t, first);
    return place;
}

/* Neighbours share pixels, so decoded depths are kept by the low bits of x and y. */
static uint32_t cohsm__slot(uint32_t pixel) { return (pixel & 15u) | (pixel >> 3 & 0x1f0u); }

COHSM__FLATTEN static void cohsm__one_light_portable(cohsm__tile *t)
{
    uint32_t place = cohsm__see_all(t), i, s;
    for (i = 0; i < t->count; i++) {
        if (t->pixel[i] == COHSM__NO_PIXEL) continue;
        s = cohsm__slot(t->pixel[i]);
        if (t->kept_pixel[s] != t->pixel[i]) {
            t->kept_pixel[s] = t->pixel[i];
            t->kept_depth[s] = cohsm__stored_depth(t->maps, t->pixel[i], place);
        }
        t->visible[i] = t->depth[i] > (int32_t)t->kept_depth[s] ? 0.0f : 1.0f;
    }
}

/* ---- >>avx2: queries, eight at a time ---- */

#if COHSM__SIMD

typedef struct cohsm__vec { __m256 x, y, z; } cohsm__vec;

COHSM__TARGET_AVX2 COHSM__FLATTEN static void cohsm__address_avx2(cohsm__tile *t, uint32_t corner,
                                                                  float (*weight)[COHSM__TILE])
{
    cohsm__address_latlong(t, corner, weight);
}

/* cohsm__list_block, whose block is then prefetched, and cohsm__depth_in_block */
typedef struct cohsm__found { const uint32_t *at; uint32_t view, sample; } cohsm__found;

/* How many of the directory's first views, from number 32 turn, are at most the view. */
COHSM__TARGET_AVX2 static inline uint32_t cohsm__begun32(const uint32_t *directory, uint32_t rest, uint32_t turn,
                                                         __m256i view)
{
    __m256i number = _mm256_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    __m256i end = _mm256_set1_epi16((short)(rest - 32u * turn < 32u ? rest - 32u * turn : 32u));
    __m256i a = _mm256_loadu_si256((const __m256i *)(const void *)(directory + 2 + 16 * turn));
    __m256i b = _mm256_loadu_si256((const __m256i *)(const void *)(directory + 10 + 16 * turn));
    a = _mm256_and_si256(_mm256_cmpeq_epi16(_mm256_min_epu16(a, view), a), _mm256_cmpgt_epi16(end, number));
    number = _mm256_add_epi16(number, _mm256_set1_epi16(16));
    b = _mm256_and_si256(_mm256_cmpeq_epi16(_mm256_min_epu16(b, view), b), _mm256_cmpgt_epi16(end, number));
    return (uint32_t)_mm_popcnt_u32((uint32_t)_mm256_movemask_epi8(_mm256_packs_epi16(a, b)));
}

COHSM__TARGET_AVX2 static void cohsm__find_block(cohsm__found *f, const uint32_t *lines)
{
    const uint32_t *directory = f->at;
    uint32_t where = directory[1], rest = (where & 0xffffu) - 1u, count, turn, line, tail;
    __m256i view = _mm256_set1_epi16((short)f->view);

    count = cohsm__begun32(directory, rest, 0, view);
    for (turn = 1; 32u * turn < rest; turn++) count += cohsm__begun32(directory, rest, turn, view);
    f->view -= cohsm__half_word(directory, count + 3u) & (0u - (uint32_t)(count > 0));
    tail = 0u - (uint32_t)(count == rest);
    line = directory[0] + (count & ~tail) - (where >> 20 & tail);
    f->at = lines + COHSM__BLOCK_WORDS * (size_t)line + (where >> 16 & 15u & tail);
    COHSM__PREFETCH(f->at);
}

COHSM__TARGET_AVX2 static inline uint32_t cohsm__found_depth(const cohsm__found *f, const uint16_t *depth_of)
{
    uint64_t marks = cohsm__marks(f->at);
    uint32_t bucket = f->view >> (f->at[0] >> 8 & 15u), at;
    at = bucket ? (uint32_t)_tzcnt_u64(_pdep_u64((uint64_t)1 << ((bucket - 1u) & 63u), ~marks)) + 1u : 0u;
    return cohsm__block_depth(f->at, depth_of, (uint32_t)_mm_popcnt_u64(marks),
                              cohsm__segment_at(f->at, marks, f->view, at));
}

COHSM__TARGET_AVX2 static void cohsm__find_depths(const cohsm_maps *m, const uint32_t *pixel, const uint32_t *place,
                                                  uint32_t count, uint32_t *depth)
{
    cohsm__found found[COHSM__STEP + 1];
    uint32_t n = 0, i;

    for (i = 0; i < count; i++) {
        uint32_t inside = pixel[i] != COHSM__NO_PIXEL;
        uint32_t entry = m->lookup[(size_t)(place[i] >> COHSM__CHUNK_BITS) * m->range + (pixel[i] & (0u - inside))];
        uint32_t listed = inside & (uint32_t)!(entry & COHSM__CONSTANT);
        depth[i] = inside ? entry & 0xffffu : (uint32_t)COHSM__INFINITE;        /* nothing is deeper */
        found[n].at = m->directories + (entry & (0u - listed));
        found[n].view = place[i] & (COHSM__CHUNK - 1u);
        found[n].sample = i;
        COHSM__PREFETCH(found[n].at);
        n += listed;
    }
    for (i = 0; i < n; i++) cohsm__find_block(&found[i], m->lines);
    for (i = 0; i < n; i++) depth[found[i].sample] = cohsm__found_depth(&found[i], m->depth_of);
}

COHSM__TARGET_AVX2 static void cohsm__search_avx2(cohsm__tile *t)
{
    uint32_t stored[COHSM__STEP], i, k, n;

    for (i = 0; i < t->count; i += n) {
        n = cohsm__min_u32(COHSM__STEP, (uint32_t)t->count - i);
        cohsm__find_depths(t->maps, t->pixel + i, t->place + i, n, stored);
        for (k = 0; k < n; k += 8) {
            __m256i depth = _mm256_loadu_si256((const __m256i *)(const void *)(t->depth + i + k));
            __m256i dark = _mm256_cmpgt_epi32(depth, _mm256_loadu_si256((const __m256i *)(const void *)(stored + k)));
            _mm256_storeu_ps(t->visible + i + k, _mm256_andnot_ps(_mm256_castsi256_ps(dark), _mm256_set1_ps(1.0f)));
        }
    }
}

/* Pixels that no slot holds yet are decoded together, up to a step of them at a time; a slot goes to the first of two
   that want it, and the other is left to the caller. */
COHSM__TARGET_AVX2 static void cohsm__keep_depths(cohsm__tile *t, uint32_t place)
{
    uint32_t pixel[COHSM__STEP], places[COHSM__STEP], depth[COHSM__STEP], n = 0, i, k, p, s;

    for (i = 0; i < t->count; i++) {
        p = t->pixel[i];
        s = cohsm__slot(p);
        if (p != t->kept_pixel[s] && p != COHSM__NO_PIXEL && !t->wanted[s]) {
            t->wanted[s] = 1;
            pixel[n] = p;
            places[n++] = place;
        }
        if (n < COHSM__STEP && (i + 1 < t->count || n == 0)) continue;
        cohsm__find_depths(t->maps, pixel, places, n, depth);
        for (k = 0; k < n; k++) {
            s = cohsm__slot(pixel[k]);
            t->kept_pixel[s] = pixel[k];
            t->kept_depth[s] = depth[k];
            t->wanted[s] = 0;
        }
        n = 0;
    }
}

COHSM__TARGET_AVX2 static cohsm__vec cohsm__all8(cohsm__v3 v)
{
    cohsm__vec r;
    r.x = _mm256_set1_ps(v.x);
    r.y = _mm256_set1_ps(v.y);
    r.z = _mm256_set1_ps(v.z);
    return r;
}

COHSM__TARGET_AVX2 COHSM__FLATTEN static uint32_t cohsm__see_all_avx2(cohsm__tile *t) { return cohsm__see_all(t); }

COHSM__TARGET_AVX2 static void cohsm__one_light_avx2(cohsm__tile *t)
{
    uint32_t place = cohsm__see_all_avx2(t), i, missed;

    cohsm__keep_depths(t, place);
    for (i = 0; i < t->count; i += 8) {
        __m256i pixel = _mm256_loadu_si256((const __m256i *)(const void *)(t->pixel + i));
        __m256i depth = _mm256_loadu_si256((const __m256i *)(const void *)(t->depth + i)), slot, tag, known, lit;
        slot = _mm256_and_si256(_mm256_srli_epi32(pixel, 3), _mm256_set1_epi32(0x1f0));
        slot = _mm256_or_si256(slot, _mm256_and_si256(pixel, _mm256_set1_epi32(15)));
        tag = _mm256_i32gather_epi32((const int *)(const void *)t->kept_pixel, slot, 4);
        known = _mm256_i32gather_epi32((const int *)(const void *)t->kept_depth, slot, 4);
        lit = _mm256_cmpeq_epi32(pixel, _mm256_set1_epi32(-1));
        tag = _mm256_or_si256(lit, _mm256_cmpeq_epi32(tag, pixel));
        lit = _mm256_or_si256(lit, _mm256_xor_si256(_mm256_cmpgt_epi32(depth, known), _mm256_set1_epi32(-1)));
        _mm256_storeu_ps(t->visible + i, _mm256_and_ps(_mm256_castsi256_ps(lit), _mm256_set1_ps(1.0f)));
        missed = ~(uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(tag)) & 255u;
        for (; missed; missed &= missed - 1u) {
            uint32_t at = i + _tzcnt_u32(missed);
            t->visible[at] = cohsm__lit(t->maps, t->pixel[at], place, t->depth[at]);
        }
    }
}

/* x, y and z of eight samples whose 24 floats follow each other. */
COHSM__TARGET_AVX2 static cohsm__vec cohsm__load8(const float *p)
{
    __m256 a = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(p)), _mm_loadu_ps(p + 12), 1);
    __m256 b = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(p + 4)), _mm_loadu_ps(p + 16), 1);
    __m256 c = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(p + 8)), _mm_loadu_ps(p + 20), 1);
    __m256 ab = _mm256_shuffle_ps(a, b, _MM_SHUFFLE(1, 0, 2, 1)), bc = _mm256_shuffle_ps(b, c, _MM_SHUFFLE(2, 1, 3, 2));
    cohsm__vec r;
    r.x = _mm256_shuffle_ps(a, bc, _MM_SHUFFLE(2, 0, 3, 0)); /* a = x y z x, b = y z x y, c = z x y z of each half */
    r.y = _mm256_shuffle_ps(ab, bc, _MM_SHUFFLE(3, 1, 2, 0));
    r.z = _mm256_shuffle_ps(ab, c, _MM_SHUFFLE(3, 0, 3, 1));
    return r;
}

/* Samples read, as long as eight together are consecutive in the query: all but the last few of a batch. */
COHSM__TARGET_AVX2 static size_t cohsm__load_points_avx2(cohsm__tile *t, cohsm__v3 c, float per_radius)
{
    const float *points = (const float *)(const void *)t->query->points;
    cohsm__vec center = cohsm__all8(c), p;
    __m256 scale = _mm256_set1_ps(per_radius);
    size_t i;
    for (i = 0; i + 8 <= t->count && t->id[i + 7] == t->id[i] + 7; i += 8) {
        p = cohsm__load8(points + 3 * t->id[i]);
        _mm256_storeu_ps(t->point[0] + i, _mm256_mul_ps(_mm256_sub_ps(p.x, center.x), scale));
        _mm256_storeu_ps(t->point[1] + i, _mm256_mul_ps(_mm256_sub_ps(p.y, center.y), scale));
        _mm256_storeu_ps(t->point[2] + i, _mm256_mul_ps(_mm256_sub_ps(p.z, center.z), scale));
    }
    return i;
}

COHSM__TARGET_AVX2 static size_t cohsm__load_directions_avx2(cohsm__tile *t)
{
    const float *lights = (const float *)(const void *)t->query->lights;
    size_t i;
    for (i = 0; i + 8 <= t->count && t->id[i + 7] == t->id[i] + 7; i += 8) {
        cohsm__vec l = cohsm__load8(lights + 3 * t->id[i]);
        _mm256_storeu_ps(t->light[0] + i, l.x);
        _mm256_storeu_ps(t->light[1] + i, l.y);
        _mm256_storeu_ps(t->light[2] + i, l.z);
    }
    return i;
}

COHSM__AVX512_BEGIN
/* One light for consecutive points with AVX-512: cohsm__load_points_avx2, cohsm__step_see and cohsm__one_light_avx2, in
   larger tiles, so that many depths are decoded together. */
enum { COHSM__STREAM = 1024, COHSM__AHEAD = 768 };      /* floats of points prefetched before they are wanted */

typedef struct cohsm__stream {
    __m512 center[3], right[3], up[3], back[3], per_radius, half, top, bias;
    __m512i side, begin, range;
    const cohsm_maps *maps;
    uint32_t count, pixel[COHSM__STREAM], list[COHSM__STREAM + 16], place[COHSM__STEP];
    int32_t  depth[COHSM__STREAM];
    uint32_t kept_pixel[COHSM__KEPT], kept_depth[COHSM__KEPT];     /* as in cohsm__tile */
} cohsm__stream;

COHSM__TARGET_AVX512 static void cohsm__stream_axis(__m512 *out, cohsm__v3 v)
{
    out[0] = _mm512_set1_ps(v.x);
    out[1] = _mm512_set1_ps(v.y);
    out[2] = _mm512_set1_ps(v.z);
}

COHSM__TARGET_AVX512 static void cohsm__stream_make(cohsm__stream *s, const cohsm_maps *maps, cohsm__v3 direction,
                                                    float bias)
{
    const cohsm__header *h = &maps->head;
    float top = (float)h->map_size;
    cohsm__frame f;
    uint32_t place = cohsm__one_frame(maps, direction, &f), k;

    cohsm__stream_axis(s->center, cohsm__v3_load(h->center));
    cohsm__stream_axis(s->right, f.right);
    cohsm__stream_axis(s->up, f.up);
    cohsm__stream_axis(s->back, f.back);
    s->per_radius = _mm512_set1_ps(1.0f / h->radius);
    s->half = _mm512_set1_ps(0.5f * top);
    s->top = _mm512_set1_ps(top);
    s->bias = _mm512_set1_ps(bias / top);
    s->side = _mm512_set1_epi32((int)h->map_size);
    s->begin = _mm512_set1_epi32((int)h->pixel_begin);
    s->range = _mm512_set1_epi32((int)maps->range);
    s->maps = maps;
    for (k = 0; k < COHSM__STEP; k++) s->place[k] = place;
    memset(s->kept_pixel, 0xff, sizeof s->kept_pixel);
    memset(s->kept_depth, 0, sizeof s->kept_depth);
}

/* x, y and z of up to 16 points whose floats follow each other, in radii about the centre. */
COHSM__TARGET_AVX512 static inline void cohsm__stream_load(const cohsm__stream *s, const float *points, unsigned lanes,
                                                           __m512 p[3])
{
    uint64_t floats = ((uint64_t)1 << 3u * lanes) - 1u;
    __m512 a = _mm512_maskz_loadu_ps((__mmask16)(floats & 0xffffu), points);
    __m512 b = _mm512_maskz_loadu_ps((__mmask16)(floats >> 16 & 0xffffu), points + 16);
    __m512 c = _mm512_maskz_loadu_ps((__mmask16)(floats >> 32), points + 32);
    __m512i at = _mm512_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21, 24, 27, 30, 33, 36, 39, 42, 45);
    int k;
    COHSM__UNROLL
    for (k = 0; k < 3; k++) {                       /* from a and b, but the last five or six, from c */
        p[k] = _mm512_permutex2var_ps(a, at, b);
        p[k] = _mm512_mask_permutexvar_ps(p[k], k < 2 ? 0xf800 : 0xfc00, at, c);
        p[k] = _mm512_mul_ps(_mm512_sub_ps(p[k], s->center[k]), s->per_radius);
        at = _mm512_add_epi32(at, _mm512_set1_epi32(1));
    }
}

COHSM__TARGET_AVX512 static inline __m512 cohsm__stream_dot(const __m512 *p, const __m512 *a)
{
    __m512 xy = _mm512_add_ps(_mm512_mul_ps(p[0], a[0]), _mm512_mul_ps(p[1], a[1]));
    return _mm512_add_ps(xy, _mm512_mul_ps(p[2], a[2]));
}

/* Pixels and compared depths; the points that are in the map. */
COHSM__TARGET_AVX512 static inline __mmask16 cohsm__stream_see(const cohsm__stream *s, const __m512 *p, __m512i *pixel,
                                                              __m512i *depth)
{
    __m512 x = _mm512_add_ps(_mm512_mul_ps(cohsm__stream_dot(p, s->right), s->half), s->half);
    __m512 y = _mm512_add_ps(_mm512_mul_ps(cohsm__stream_dot(p, s->up), s->half), s->half);
    __m512 d = cohsm__stream_dot(p, s->back), half = _mm512_set1_ps(0.5f), zero = _mm512_setzero_ps();
    __mmask16 in;
    d = _mm512_sub_ps(_mm512_sub_ps(half, _mm512_mul_ps(half, d)), s->bias);
    d = _mm512_mul_ps(d, _mm512_set1_ps((float)COHSM__HIT_MAX));
    in = _mm512_cmp_ps_mask(x, zero, _CMP_GE_OQ) & _mm512_cmp_ps_mask(x, s->top, _CMP_LT_OQ) &
         _mm512_cmp_ps_mask(y, zero, _CMP_GE_OQ) & _mm512_cmp_ps_mask(y, s->top, _CMP_LT_OQ) &
         _mm512_cmp_ps_mask(d, zero, _CMP_GE_OQ);
    *pixel = _mm512_mullo_epi32(_mm512_maskz_cvttps_epi32(in, y), s->side);
    *pixel = _mm512_sub_epi32(_mm512_add_epi32(*pixel, _mm512_maskz_cvttps_epi32(in, x)), s->begin);
    *depth = _mm512_maskz_cvttps_epi32(in, _mm512_min_ps(d, _mm512_set1_ps(65535.0f)));
    return in & _mm512_cmplt_epu32_mask(*pixel, s->range);
}

COHSM__TARGET_AVX512 static inline __m512i cohsm__slot16(__m512i pixel)
{
    __m512i high = _mm512_and_si512(_mm512_srli_epi32(pixel, 3), _mm512_set1_epi32(0x1f0));
    return _mm512_or_si512(high, _mm512_and_si512(pixel, _mm512_set1_epi32(15)));
}

/* Pixels that no slot holds take theirs and join the list, each once: where lanes want one slot, one of them gets it.
   The slots' depths, unknown yet, serve to find out which. */
COHSM__TARGET_AVX512 static uint32_t cohsm__stream_mark(cohsm__stream *s, __m512i pixel, __m512i slot, __mmask16 missed,
                                                        uint32_t *list)
{
    __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    _mm512_mask_i32scatter_epi32(s->kept_depth, missed, slot, lane, 4);
    missed = _mm512_mask_cmpeq_epi32_mask(missed, lane, _mm512_i32gather_epi32(slot, s->kept_depth, 4));
    _mm512_mask_i32scatter_epi32(s->kept_pixel, missed, slot, pixel, 4);
    _mm512_storeu_si512(list, _mm512_maskz_compress_epi32(missed, pixel));
    return (uint32_t)_mm_popcnt_u32(missed);
}

/* A tile's pixels and compared depths. Returns how many pixels are listed to be decoded. */
COHSM__TARGET_AVX512 static uint32_t cohsm__stream_find(cohsm__stream *s, const float *points)
{
    uint32_t k, n = 0;
    for (k = 0; k < s->count; k += 16, points += 48) {
        __m512i pixel, depth, slot;
        __m512 p[3];
        __mmask16 in, missed;
        COHSM__PREFETCH(points + COHSM__AHEAD);
        COHSM__PREFETCH(points + COHSM__AHEAD + 16);
        COHSM__PREFETCH(points + COHSM__AHEAD + 32);
        cohsm__stream_load(s, points, cohsm__min_u32(s->count - k, 16), p);
        in = cohsm__stream_see(s, p, &pixel, &depth);
        pixel = _mm512_mask_mov_epi32(_mm512_set1_epi32(-1), in, pixel);        /* COHSM__NO_PIXEL */
        slot = cohsm__slot16(pixel);
        missed = _mm512_mask_cmpneq_epi32_mask(in, pixel, _mm512_i32gather_epi32(slot, s->kept_pixel, 4));
        _mm512_storeu_si512(s->pixel + k, pixel);
        _mm512_storeu_si512(s->depth + k, depth);
        if (missed) n += cohsm__stream_mark(s, pixel, slot, missed, s->list + n);
    }
    return n;
}

COHSM__TARGET_AVX2 static void cohsm__stream_decode(cohsm__stream *s, uint32_t count)
{
    uint32_t depth[COHSM__STEP], i, k, n;
    for (i = 0; i < count; i += n) {
        const uint32_t *pixel = s->list + i;
        n = cohsm__min_u32(count - i, COHSM__STEP);
        cohsm__find_depths(s->maps, pixel, s->place, n, depth);
        for (k = 0; k < n; k++)                     /* where no other has taken the slot since */
            if (s->kept_pixel[cohsm__slot(pixel[k])] == pixel[k]) s->kept_depth[cohsm__slot(pixel[k])] = depth[k];
    }
}

COHSM__TARGET_AVX512 static void cohsm__stream_compare(const cohsm__stream *s, float *visible)
{
    uint32_t k, at;
    for (k = 0; k < s->count; k += 16) {
        unsigned valid = s->count - k < 16 ? (1u << (s->count - k)) - 1u : 0xffffu, taken;
        __m512i pixel = _mm512_loadu_si512(s->pixel + k), slot = cohsm__slot16(pixel);
        __mmask16 in = _mm512_cmpneq_epi32_mask(pixel, _mm512_set1_epi32(-1));
        __mmask16 dark = _mm512_mask_cmpgt_epi32_mask(in, _mm512_loadu_si512(s->depth + k),
                                                      _mm512_i32gather_epi32(slot, s->kept_depth, 4));
        taken = _mm512_mask_cmpneq_epi32_mask(in, pixel, _mm512_i32gather_epi32(slot, s->kept_pixel, 4)) & valid;
        _mm512_mask_storeu_ps(visible + k, (__mmask16)valid, _mm512_mask_blend_ps(dark, _mm512_set1_ps(1.0f),
                                                                                  _mm512_setzero_ps()));
        for (; taken; taken &= taken - 1u) {
            at = k + _tzcnt_u32(taken);
            visible[at] = cohsm__lit(s->maps, s->pixel[at], s->place[0], s->depth[at]);
        }
    }
}

COHSM__TARGET_AVX512 static void cohsm__one_light_avx512(const cohsm_maps *maps, const cohsm_query *q,
                                                         cohsm__v3 direction, float *visible)
{
    size_t first;
    cohsm__stream s;

    cohsm__stream_make(&s, maps, direction, q->bias);
    for (first = 0; first < q->count; first += s.count) {
        s.count = q->count - first < COHSM__STREAM ? (uint32_t)(q->count - first) : (uint32_t)COHSM__STREAM;
        cohsm__stream_decode(&s, cohsm__stream_find(&s, q->points + 3 * first));
        cohsm__stream_compare(&s, visible + first);
    }
}
COHSM__AVX512_END

#endif

/* Looks up one corner of every sample. */
static void cohsm__run_corner(cohsm__tile *t, uint32_t corner, float (*weight)[COHSM__TILE])
{
    size_t i;
#if COHSM__SIMD
    if (t->maps->simd) {
        cohsm__address_avx2(t, corner, weight);
        cohsm__search_avx2(t);
        return;
    }
#endif
    for (i = 0; i < t->count; i++) t->visible[i] = 1.0f;
    cohsm__address_portable(t, corner, weight);
    cohsm__search(t);
}

/* cohsm__pcf for the whole tile: sums in the same order. */
static void cohsm__run_pcf(cohsm__tile *t)
{
    float weight[4][COHSM__TILE], dark[COHSM__TILE], map[COHSM__TILE], w;
    uint32_t corner, d;
    size_t i;

    memset(dark, 0, sizeof dark);
    for (corner = 0; corner < 16; corner++) {       /* pixels fastest: turned, the low two bits are the pixel's */
        uint32_t turned = corner >> 2 | (corner & 3u) << 2;
        cohsm__run_corner(t, turned, weight);
        for (i = 0; i < t->count; i++) {
            w = 1.0f;
            for (d = 2; d < 4; d++) w *= turned >> d & 1u ? weight[d][i] : 1.0f - weight[d][i];
            map[i] = (corner & 3u ? map[i] : 0.0f) + w * (1.0f - t->visible[i]);
            if ((corner & 3u) < 3) continue;
            w = 1.0f;
            for (d = 0; d < 2; d++) w *= turned >> d & 1u ? weight[d][i] : 1.0f - weight[d][i];
            dark[i] += w * map[i];
        }
    }
    for (i = 0; i < t->count; i++) t->visible[i] = cohsm__lit_of(dark[i]);
}

/* 0 where the samples are of a kind that is treated one by one. */
static int cohsm__run_steps(cohsm__tile *t)
{
    const cohsm_maps *m = t->maps;
    int shared = t->one_light && t->query->filter == COHSM_FILTER_NEAREST;
    size_t i;

    if (t->query->light != COHSM_LIGHT_DIRECTION) return 0;
    if (shared ? !cohsm__usable(cohsm__tile_light(t, 0)) : m->head.domain != COHSM_DOMAIN_LATLONG) return 0;
    for (i = t->count; i % COHSM__STEP; i++) {      /* what the last step has too much */
        t->point[0][i] = t->point[1][i] = t->point[2][i] = 0.0f;
        t->id[i] = 0;
    }
    for (i = t->one_light ? 0 : t->count; !shared && (i < t->count || i % COHSM__STEP); i++) {
        t->light[0][i] = t->light[0][0];
        t->light[1][i] = t->light[1][0];
        t->light[2][i] = t->light[2][0];
    }
    if (t->query->filter == COHSM_FILTER_PCF) cohsm__run_pcf(t);
    else if (!shared) cohsm__run_corner(t, 0, NULL);
#if COHSM__SIMD
    else if (m->simd) cohsm__one_light_avx2(t);
#endif
    else cohsm__one_light_portable(t);
    return 1;
}

static void cohsm__run_tile(cohsm__tile *t)
{
    size_t i;
    for (i = 0; i < t->count; i++) t->visible[i] = 1.0f;
    if (cohsm__run_steps(t)) return;
    for (i = 0; i < t->count; i++) {
        t->pixel[i] = COHSM__NO_PIXEL;
        if (t->query->light == COHSM_LIGHT_POSITION) {
            cohsm__v3 l = cohsm__tile_light(t, i);
            if (!cohsm__v3_finite(l)) continue;
            if (cohsm__light_refused(t->maps, l)) {
                t->visible[i] = COHSM_REFUSED;
                continue;
            }
            if (!cohsm__hull_between(t->maps, cohsm__tile_point(t, i), l)) continue;
        }
        cohsm__address(t, i);
    }
    if (t->query->filter != COHSM_FILTER_PCF) cohsm__search(t);
}

/* ---- >>scene: samples to the objects' spaces and back ---- */

static size_t cohsm__light_size(const cohsm_maps *m, cohsm_light kind)
{
    if (kind == COHSM_LIGHT_INDEX) return 4;
    return kind == COHSM_LIGHT_PARAMETER ? 4 * (size_t)m->head.dimensions : 12;
}

/* Lights of the samples in id[], or the one for all, to the object's space. */
static void cohsm__load_lights(cohsm__tile *t, const float *inverse)
{
    const cohsm_query *q = t->query;
    const cohsm__header *h = &t->maps->head;
    size_t size = cohsm__light_size(t->maps, q->light), stride = q->light_stride ? q->light_stride : size, i;
    size_t count = t->one_light ? (t->count ? 1 : 0) : t->count;
    cohsm__v3 c = cohsm__v3_load(h->center), l;
    float per_radius = 1.0f / h->radius, v[3] = { 0, 0, 0 };

    i = 0;
#if COHSM__SIMD
    if (t->maps->simd && q->light == COHSM_LIGHT_DIRECTION && !inverse && stride == 12 && !t->one_light)
        i = cohsm__load_directions_avx2(t);
#endif
    for (; i < count; i++) {
        const char *from = (const char *)q->lights + stride * (t->one_light ? 0 : t->id[i]);
        if (q->light == COHSM_LIGHT_INDEX) {
            memcpy(&t->cell[i], from, 4);
            continue;
        }
        if (q->light == COHSM_LIGHT_PARAMETER) memcpy(v, from, size);
        else memcpy(v, from, sizeof v);
        l = cohsm__v3_load(v);
        if (q->light == COHSM_LIGHT_DIRECTION && inverse) l = cohsm__m4_direction(inverse, l);
        if (q->light == COHSM_LIGHT_POSITION && inverse) l = cohsm__m4_point(inverse, l);
        if (q->light == COHSM_LIGHT_POSITION) l = cohsm__v3_scale(cohsm__v3_sub(l, c), per_radius);
        t->light[0][i] = l.x;
        t->light[1][i] = l.y;
        t->light[2][i] = l.z;
    }
}

static void cohsm__load_tile(cohsm__tile *t, const float *inverse)
{
    const cohsm_query *q = t->query;
    size_t stride = q->point_stride ? q->point_stride : 12, i = 0;
    cohsm__v3 c = cohsm__v3_load(t->maps->head.center), p;
    float per_radius = 1.0f / t->maps->head.radius, v[3];

#if COHSM__SIMD
    if (t->maps->simd && !inverse && stride == 12) i = cohsm__load_points_avx2(t, c, per_radius);
#endif
    for (; i < t->count; i++) {
        memcpy(v, (const char *)q->points + stride * t->id[i], sizeof v);
        p = cohsm__v3_load(v);
        if (inverse) p = cohsm__m4_point(inverse, p);
        p = cohsm__v3_scale(cohsm__v3_sub(p, c), per_radius);
        t->point[0][i] = p.x;
        t->point[1][i] = p.y;
        t->point[2][i] = p.z;
    }
    cohsm__load_lights(t, inverse);
}

/* The whole batch at once; 0 where it is of a kind that is treated in tiles. */
static int cohsm__run_stream(const cohsm_maps *m, const cohsm_query *q, float *visible)
{
#if COHSM__SIMD
    float v[3];
    if (m->simd < 2 || !q->count || !q->one_light || q->filter != COHSM_FILTER_NEAREST ||
        q->light != COHSM_LIGHT_DIRECTION || (q->point_stride && q->point_stride != 12))
        return 0;
    memcpy(v, q->lights, sizeof v);
    if (!cohsm__usable(cohsm__v3_load(v))) return 0;
    cohsm__one_light_avx512(m, q, cohsm__v3_load(v), visible);
    return 1;
#else
    (void)m;
    (void)q;
    (void)visible;
    return 0;
#endif
}

static cohsm_result cohsm__check_query(const cohsm_maps *m, const cohsm_query *q)
{
    if (!q->points || !q->lights || (unsigned)q->light > COHSM_LIGHT_INDEX ||
        (unsigned)q->filter > COHSM_FILTER_ROULETTE)
        return COHSM_ERR_ARGUMENT;
    if (!cohsm__finite(q->bias) || q->bias < 0.0f) return COHSM_ERR_ARGUMENT;
    if ((q->point_stride && q->point_stride < 12) || q->point_stride % 4 || q->light_stride % 4 ||
        (q->light_stride && q->light_stride < cohsm__light_size(m, q->light)))
        return COHSM_ERR_ARGUMENT;
    if (q->light == COHSM_LIGHT_INDEX) return COHSM_OK;
    if (q->light == COHSM_LIGHT_PARAMETER) return m->head.dimensions ? COHSM_OK : COHSM_ERR_DOMAIN;
    return m->head.domain == COHSM_DOMAIN_LATLONG || m->head.domain == COHSM_DOMAIN_OCTAHEDRAL ? COHSM_OK
                                                                                               : COHSM_ERR_DOMAIN;
}

static size_t cohsm__count_refused(const float *visible, size_t count)
{
    size_t i, n = 0;
    for (i = 0; i < count; i++) n += visible[i] == COHSM_REFUSED;
    return n;
}

COHSM_DEF cohsm_query cohsm_query_default(void)
{
    cohsm_query q;
    memset(&q, 0, sizeof q);
    q.bias = 1.0f;
    return q;
}

static void cohsm__run_tiles(const cohsm_maps *maps, const cohsm_query *query, float *visible)
{
    cohsm__tile t;
    size_t begin, i;

    cohsm__tile_start(&t, query, maps, 0);
    for (begin = 0; begin < query->count; begin += t.count) {
        t.count = query->count - begin < COHSM__TILE ? query->count - begin : (size_t)COHSM__TILE;
        for (i = 0; i < t.count; i++) t.id[i] = begin + i;
        cohsm__load_tile(&t, NULL);
        cohsm__run_tile(&t);
        memcpy(visible + begin, t.visible, t.count * sizeof *visible);
    }
}

COHSM_DEF cohsm_result cohsm_visible(const cohsm_maps *maps, const cohsm_query *query, float *visible, size_t *refused)
{
    cohsm_result result;

    if (!maps || !query || (query->count && !visible)) return COHSM_ERR_ARGUMENT;
    if (query->count) {
        result = cohsm__check_query(maps, query);
        if (result != COHSM_OK) return result;
    }
    if (!cohsm__run_stream(maps, query, visible)) cohsm__run_tiles(maps, query, visible);
    if (refused) *refused = cohsm__count_refused(visible, query->count);
    return COHSM_OK;
}

static void cohsm__flush_tile(cohsm__tile *t, const float *inverse, float *visible)
{
    size_t i;
    cohsm__load_tile(t, inverse);
    cohsm__run_tile(t);
    for (i = 0; i < t->count; i++) {
        float *v = visible + t->id[i];
        if (t->visible[i] == COHSM_REFUSED) *v = COHSM_REFUSED;
        else *v *= t->visible[i];
    }
    t->count = 0;
}

/* own = 1: samples that lie on this instance; 0: all others that still see some light. */
static void cohsm__visit(cohsm__tile *t, const cohsm_query *q, uint32_t self, int own, const float *inverse,
                         float *visible)
{
    size_t i;
    t->count = 0;
    for (i = 0; i < q->count; i++) {
        if ((q->self && q->self[i] == self) != own || !(visible[i] > 0.0f)) continue;
        t->id[t->count++] = i;
        if (t->count == COHSM__TILE) cohsm__flush_tile(t, inverse, visible);
    }
    if (t->count) cohsm__flush_tile(t, inverse, visible);
}

COHSM_DEF cohsm_result cohsm_visible_scene(const cohsm_instance *instances, size_t instance_count,
                                           const cohsm_query *query, float *visible, size_t *refused)
{
    cohsm__tile t;
    float inverse[16], scale;
    size_t i;
    int own;
    cohsm_result result;

    if (!query || (instance_count && !instances) || (query->count && !visible) || instance_count >= COHSM_NO_SELF)
        return COHSM_ERR_ARGUMENT;
    for (i = 0; i < instance_count; i++) {
        if (!instances[i].maps || !cohsm__m4_is_rigid_uniform(instances[i].transform, &scale) ||
            !cohsm__m4_affine_inverse(inverse, instances[i].transform))
            return COHSM_ERR_ARGUMENT;
        result = query->count ? cohsm__check_query(instances[i].maps, query) : COHSM_OK;
        if (result != COHSM_OK) return result;
    }
    for (i = 0; i < query->count; i++) visible[i] = 1.0f;
    for (own = query->self != NULL; own >= 0; own--)
        for (i = 0; i < instance_count; i++) {
            cohsm__tile_start(&t, query, instances[i].maps, (uint32_t)i);
            cohsm__m4_affine_inverse(inverse, instances[i].transform);
            cohsm__visit(&t, query, (uint32_t)i, own, inverse, visible);
        }
    if (refused) *refused = cohsm__count_refused(visible, query->count);
    return COHSM_OK;
}

/* ---- >>verify: every stored value against its interval ---- */

typedef struct cohsm__check {
    const cohsm_builder *builder;       /* for layers and intervals; its batch holds the views */
    const cohsm_maps    *maps;
    cohsm_report         part[COHSM__RANGES];
} cohsm__check;

/* The stored depth, and the first view after its segment. */
static uint32_t cohsm__segment_depth(const cohsm_maps *m, uint32_t pixel, uint32_t view, uint32_t *end)
{
    uint32_t begin = view & ~(COHSM__CHUNK - 1u),
             entry = m->lookup[(size_t)(view >> COHSM__CHUNK_BITS) * m->range + pixel];
    uint32_t b = 0, count, n, j, k, at, bucket;
    const uint32_t *directory = m->directories + entry, *block;
    uint64_t marks;

    *end = cohsm__min_u32(m->head.view_count, begin + COHSM__CHUNK);
    if (entry & COHSM__CONSTANT) return entry & 0xffffu;
    count = cohsm__block_count(directory);
    while (b + 1 < count && cohsm__block_first(directory, b + 1u) <= view - begin) b++;
    if (b + 1 < count) *end = begin + cohsm__block_first(directory, b + 1u);
    if (b) begin += cohsm__block_first(directory, b);
    block = cohsm__block_at(directory, m->lines, b);
    marks = cohsm__marks(block);
    n = cohsm__popcount(marks);
    j = cohsm__block_find(block, view - begin);
    if (j + 1 < n) {                                /* the next mark, and its low bits */
        k = block[0] >> 8 & 15u;
        for (at = 0, count = 0; count <= j + 1u; at++) count += (uint32_t)(marks >> at & 1u);
        bucket = at - 1u - (j + 1u);
        *end = begin + (bucket << k | cohsm__bits(block, COHSM__LOW_AT + (j + 1u) * k, k));
    }
    return cohsm__block_depth(block, m->depth_of, n, j);
}

/* A range of pixels in all views of the batch, pixel by pixel: a list is read once for many views. */
static void cohsm__verify_task(void *context, size_t index)
{
    cohsm__check *k = (cohsm__check *)context;
    const cohsm_builder *b = k->builder;
    cohsm_report *r = &k->part[index];
    uint32_t p, i, view, end, lo, hi, z = 0;

    memset(r, 0, sizeof *r);
    for (p = b->ranges[index].begin; p < b->ranges[index].end; p++) {
        const uint16_t *layers = b->batch + (size_t)(b->desc.pixel_begin + p) * b->keep;
        for (i = 0, end = 0; i < b->batch_count; i++, layers += b->batch_size) {
            view = b->batch_begin + i;
            if (view >= end) z = cohsm__segment_depth(k->maps, p, view, &end);
            r->empty += (uint64_t)cohsm__interval(b, layers, &lo, &hi);
            r->entries++;
            if ((z >= lo && z <= hi) || (r->wrong++ && view >= r->first_view)) continue;
            r->first_view = view;
            r->first_pixel = p + b->desc.pixel_begin;
        }
    }
}

/* The desc that a block was built with, but for the caller's services. */
static cohsm_desc cohsm__desc_of(const cohsm_maps *m, const cohsm_desc *services)
{
    const cohsm__header *h = &m->head;
    cohsm_desc d;

    memset(&d, 0, sizeof d);
    if (services) {
        d.allocator = services->allocator;
        d.parallel_for = services->parallel_for;
        d.parallel_user = services->parallel_user;
        d.progress = services->progress;
        d.progress_user = services->progress_user;
    }
    d.domain.kind = (cohsm_domain_kind)h->domain;
    memcpy(d.domain.side, h->side, sizeof h->side);
    memcpy(d.domain.origin, h->origin, sizeof h->origin);
    memcpy(d.domain.u, h->u, sizeof h->u);
    memcpy(d.domain.v, h->v, sizeof h->v);
    memcpy(d.domain.w, h->w, sizeof h->w);
    if (h->location_words) {
        d.domain.locations = m->locations;
        d.domain.location_count = h->map_count;
    }
    d.map_size = h->map_size;
    d.layers = (cohsm_layers)h->layers;
    d.order = (cohsm_order)h->order;
    d.frame = (cohsm_frame)h->frame;
    d.depth_bits = h->depth_bits;
    d.open_thickness = h->open_thickness;
    d.self_only = (int)h->self_only;
    memcpy(d.center, h->center, sizeof h->center);
    d.radius = h->radius;
    d.pixel_begin = h->pixel_begin;
    d.pixel_end = h->pixel_end;
    return d;
}

static cohsm_result cohsm__verify_views(cohsm_builder *b, const cohsm_maps *maps, const cohsm__soup *soup,
                                        cohsm_report *out)
{
    cohsm__job job;
    cohsm__check check;
    uint64_t wrong_before;
    uint32_t i;

    job.builder = b;
    job.soup = soup;
    job.simd = cohsm__simd();
    check.builder = b;
    check.maps = maps;
    for (; b->batch_begin < b->head.view_count; b->batch_begin += b->batch_count) {
        if (b->desc.progress &&
            b->desc.progress(b->desc.progress_user, (float)b->batch_begin / (float)b->head.view_count))
            return COHSM_ERR_CANCELLED;
        b->batch_count = cohsm__min_u32(COHSM__BATCH, b->head.view_count - b->batch_begin);
        cohsm__run(&b->parallel, b->batch_count, cohsm__raster_task, &job);
        cohsm__run(&b->parallel, COHSM__RANGES, cohsm__verify_task, &check);
        for (i = 0, wrong_before = out->wrong; i < COHSM__RANGES; i++) {
            const cohsm_report *r = &check.part[i];
            if (r->wrong && !wrong_before && (!out->wrong || r->first_view < out->first_view)) {
                out->first_view = r->first_view;
                out->first_pixel = r->first_pixel;
            }
            out->entries += r->entries;
            out->wrong += r->wrong;
            out->empty += r->empty;
        }
    }
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_verify(const cohsm_maps *maps, const cohsm_desc *desc, const cohsm_mesh *mesh,
                                    cohsm_report *out)
{
    cohsm_desc d;
    cohsm_stats stats;
    cohsm__heap heap;
    cohsm__model model;
    cohsm_report report;
    cohsm_builder *b;
    cohsm_result result;

    if (!maps || !mesh || !out) return COHSM_ERR_ARGUMENT;
    if (desc && !cohsm__allocator_valid(desc->allocator.alloc_fn, desc->allocator.free_fn)) return COHSM_ERR_DESC;
    d = cohsm__desc_of(maps, desc);
    memset(&stats, 0, sizeof stats);
    memset(&heap, 0, sizeof heap);
    memset(&model, 0, sizeof model);
    memset(&report, 0, sizeof report);
    heap.allocator = cohsm__allocator_make(d.allocator.alloc_fn, d.allocator.free_fn, d.allocator.user);
    result = cohsm__model_make(&model, &d, mesh, &heap, &stats);
    if (result == COHSM_OK) {
        result = cohsm__builder_make(&d, &heap, &b);
        if (result == COHSM_OK) {
            result = cohsm__verify_views(b, maps, &model.soup, &report);
            cohsm__drop_builder(b, &heap);
        }
    }
    cohsm__soup_free(&model.soup, &heap);
    if (result == COHSM_OK) *out = report;
    return result;
}

/* ---- >>shards ---- */

/* Shards of one build differ in their pixels, lengths and counts only. */
static int cohsm__same_build(const cohsm_maps *a, const cohsm_maps *b)
{
    cohsm__header x = a->head, y = b->head;
    size_t before = (size_t)x.order_words + x.location_words;
    x.words = y.words = x.crc = y.crc = 0;
    x.pixel_begin = y.pixel_begin = x.pixel_end = y.pixel_end = 0;
    x.lookup_words = y.lookup_words = x.directory_words = y.directory_words = x.line_words = y.line_words = 0;
    x.segments_low = y.segments_low = x.segments_high = y.segments_high = 0;
    return memcmp(&x, &y, sizeof x) == 0 &&
           memcmp(a->words + COHSM__HEADER_WORDS, b->words + COHSM__HEADER_WORDS, 4 * before) == 0;
}

enum { COHSM__LISTS_COPIED = 4096, COHSM__LISTS_CODED = 64 };   /* between two calls of progress: milliseconds */

/* 0: cancelled. */
static int cohsm__lay_shards(const cohsm_maps *const *shards, size_t count, cohsm__part part, cohsm__layout *l,
                             uint32_t *lookup)
{
    uint32_t chunk, chunks = cohsm__chunks(&shards[0]->head), p, dry_entry;
    size_t i, done = 0, lists = (size_t)shards[count - 1u]->head.pixel_end * chunks;

    for (chunk = 0; chunk < chunks; chunk++)
        for (i = 0; i < count; i++) {
            const cohsm_maps *s = shards[i];
            for (p = 0; p < s->range; p++) {
                uint32_t entry = s->lookup[(size_t)chunk * s->range + p], *at = lookup ? lookup++ : &dry_entry, blocks;
                const uint32_t *directory = s->directories + entry;
                if (cohsm__cancelled(&part, done++, lists, COHSM__LISTS_COPIED)) return 0;
                *at = entry;
                if (entry & COHSM__CONSTANT) continue;
                blocks = cohsm__block_count(directory);
                cohsm__lay_list(l, at, blocks, directory, 3, cohsm__block_at(directory, s->lines, 0),
                                cohsm__block_at(directory, s->lines, blocks - 1u));
            }
        }
    return 1;
}

static cohsm_result cohsm__join(const cohsm_maps *const *shards, size_t count, cohsm__header *h,
                                const cohsm__allocator *a, const cohsm__part *part, cohsm_maps **out)
{
    cohsm__layout layout;
    cohsm__memory block;
    uint32_t *lookup;
    cohsm_result result;

    memset(&layout, 0, sizeof layout);
    if (!cohsm__lay_shards(shards, count, cohsm__part_of(part, 0.0f, 0.5f), &layout, NULL)) return COHSM_ERR_CANCELLED;
    result = cohsm__size_block(h, &layout);
    if (result != COHSM_OK) return result;
    block = cohsm__take_block(a, h->words);
    if (!block.words) return COHSM_ERR_ALLOC;
    memcpy(block.words + COHSM__HEADER_WORDS, shards[0]->words + COHSM__HEADER_WORDS,
           4 * ((size_t)h->order_words + h->location_words));
    cohsm__layout_into(&layout, h, block.words, &lookup);
    if (!cohsm__lay_shards(shards, count, cohsm__part_of(part, 0.5f, 1.0f), &layout, lookup)) {
        cohsm__free(a, block.memory);
        return COHSM_ERR_CANCELLED;
    }
    cohsm__seal(block.words, h);
    return cohsm__maps_make(a, block, out);
}

COHSM_DEF cohsm_result cohsm_merge(const cohsm_maps *const *shards, size_t count, const cohsm_desc *desc,
                                   cohsm_maps **out)
{
    cohsm__allocator a;
    cohsm__part part;
    uint64_t segments = 0;
    cohsm__header h;
    uint32_t next = 0;
    size_t i;

    if (!shards || !count || !out) return COHSM_ERR_ARGUMENT;
    if (!cohsm__services_of(desc, &a, &part)) return COHSM_ERR_DESC;
    for (i = 0; i < count; i++) {
        if (!shards[i]) return COHSM_ERR_ARGUMENT;
        if (!cohsm__same_build(shards[0], shards[i]) || shards[i]->head.pixel_begin != next) return COHSM_ERR_MISMATCH;
        next = shards[i]->head.pixel_end;
        segments += (uint64_t)shards[i]->head.segments_high << 32 | shards[i]->head.segments_low;
    }
    h = shards[0]->head;
    if (next != h.map_size * h.map_size) return COHSM_ERR_MISMATCH;
    h.pixel_end = next;
    h.lookup_words = next * cohsm__chunks(&h);
    h.segments_low = (uint32_t)(segments & 0xffffffffu);
    h.segments_high = (uint32_t)(segments >> 32);
    return cohsm__join(shards, count, &h, &a, &part, out);
}

/* ---- >>open: files, which may be hostile ---- */

static int cohsm__header_sound(const cohsm__header *h)
{
    cohsm_domain_kind kind = (cohsm_domain_kind)h->domain;
    uint64_t n = (uint64_t)h->side[0] * h->side[1], total;
    uint32_t order;
    size_t i;

    if (h->domain == 0 || h->domain >= COHSM_DOMAIN_KIND_COUNT || h->layers == 0 || h->layers >= COHSM_LAYERS_COUNT ||
        h->order == 0 || h->order >= COHSM_ORDER_COUNT || h->frame == 0 || h->frame >= COHSM_FRAME_COUNT)
        return 0;
    for (i = 0; i < 3; i++)
        if (h->side[i] == 0 || h->side[i] > (cohsm__has_table(h->domain) ? 1u << 24 : 4096u)) return 0;
    if (n > 1u << 24 || n * h->side[2] > 1u << 24 || n * h->side[2] != h->map_count) return 0;
    if (h->positional > 1 || h->self_only > 1 || h->view_count != h->map_count * (h->positional ? 6u : 1u)) return 0;
    if (kind == COHSM_DOMAIN_LATLONG || kind == COHSM_DOMAIN_OCTAHEDRAL) {
        if (h->positional || h->side[2] != 1) return 0;
    } else if (!cohsm__has_table(h->domain) && !h->positional) return 0;
    if (h->dimensions != cohsm__dimensions(kind, h->side)) return 0;
    if (h->map_size < 4 || h->map_size > 1024 || h->depth_bits < 4 || h->depth_bits > 8) return 0;
    if (h->pixel_begin >= h->pixel_end || h->pixel_end > h->map_size * h->map_size) return 0;
    order = h->order != COHSM_ORDER_HILBERT ? 0 : h->map_count <= 65536 ? (h->map_count + 1) / 2 : h->map_count;
    if (h->order_words != order || h->location_words != (cohsm__has_table(h->domain) ? 4 * h->map_count : 0)) return 0;
    total = (uint64_t)(h->pixel_end - h->pixel_begin) * cohsm__chunks(h);
    if (total != h->lookup_words || h->line_words % COHSM__BLOCK_WORDS != COHSM__PADDING) return 0;
    total += (uint64_t)COHSM__HEADER_WORDS + order + h->location_words + h->directory_words;
    if (total % COHSM__BLOCK_WORDS) return 0;
    total += h->line_words;
    if (total != h->words || total > 0x3fffffffu) return 0;
    if (!cohsm__floats_finite(h) || !(h->open_thickness > 0.0f && h->open_thickness <= 1024.0f)) return 0;
    if (!cohsm__radius_usable(h->radius) || (h->positional && !(h->depth_far > 0.0f))) return 0;
    for (i = 0; i < sizeof h->reserved / sizeof h->reserved[0]; i++)
        if (h->reserved[i]) return 0;
    return 1;
}

/* One block within the words that are left of its line: its parts lie inside it, its segments rise and stay
   below end. */
static int cohsm__block_sound(const uint32_t *block, uint32_t left, uint32_t views)
{
    uint32_t n, exact = 0, j, at, bucket = 0, low, offset, previous = 0, size, code;
    uint64_t marks;
    cohsm__fields f;

    if (left < 3) return 0;
    marks = cohsm__marks(block);
    n = cohsm__popcount(marks);
    f = cohsm__block_fields(block, n);
    if (!(marks & 1u) || f.bits == 0 || f.exact_at > COHSM__BLOCK_BITS || (f.exact_at + 31u) / 32u > left) return 0;
    if ((block[0] >> 12 & 15u) > COHSM__WIDEST && f.palette == 0) return 0;
    for (j = 0; j < n; j++) {
        code = cohsm__bits(block, f.codes_at + j * f.bits, f.bits);
        if (code + 1u == 1u << f.bits) exact++;
        else if (f.palette ? code >= f.palette : code + 2u < 1u << f.bits && (block[0] & 255u) + code > 254u) return 0;
    }
    size = f.exact_at + 16u * exact;
    if (size > COHSM__BLOCK_BITS || (size + 31u) / 32u > left) return 0;
    for (at = 0, j = 0; j < n; at++) {
        if (!(marks >> at & 1u)) {
            bucket++;
            continue;
        }
        low = cohsm__bits(block, COHSM__LOW_AT + j * f.k, f.k);
        offset = (bucket << f.k) + low;
        if (j == 0 ? offset != 0 : offset <= previous) return 0;
        previous = offset;
        j++;
    }
    if (previous >= views) return 0;
    return ((views - 1u) >> f.k) + n <= COHSM__MARKS;    /* every bucket that a search may ask for is marked */
}

static int cohsm__list_sound(const cohsm_maps *m, uint32_t entry, uint32_t views)
{
    const uint32_t *directory = m->directories + entry;
    uint32_t lines = m->head.line_words / COHSM__BLOCK_WORDS, left = m->head.directory_words - entry, blocks, tail, b;
    uint32_t first = 0, next;

    if (left < 2) return 0;
    blocks = cohsm__block_count(directory);
    tail = directory[1] >> 16;
    if (blocks == 0 || 2u + blocks / 2u > left) return 0;
    if (directory[0] > lines || blocks - 1u > lines - directory[0]) return 0;
    if (tail >> 4 > directory[0] || directory[0] - (tail >> 4) >= lines) return 0;
    for (b = 0; b < blocks; b++) {
        next = b + 1 < blocks ? cohsm__block_first(directory, b + 1) : views;
        if (next <= first || next > views) return 0;
        if (!cohsm__block_sound(cohsm__block_at(directory, m->lines, b),
                                b + 1 < blocks ? (uint32_t)COHSM__BLOCK_WORDS : COHSM__BLOCK_WORDS - (tail & 15u),
                                next - first))
            return 0;
        first = next;
    }
    return 1;
}

static cohsm_result cohsm__check_lists(const cohsm_maps *m, cohsm__part part)
{
    uint32_t entry, views, chunk, chunks = cohsm__chunks(&m->head);
    size_t i;

    for (i = 0; i < m->head.lookup_words; i++) {
        if (cohsm__cancelled(&part, i, m->head.lookup_words, COHSM__LISTS_COPIED)) return COHSM_ERR_CANCELLED;
        chunk = (uint32_t)(i / m->range);
        views = chunk + 1 < chunks ? COHSM__CHUNK : m->head.view_count - chunk * COHSM__CHUNK;
        entry = m->lookup[i];
        if (entry & COHSM__CONSTANT ? entry & 0x7fff0000u
                                    : entry >= m->head.directory_words || !cohsm__list_sound(m, entry, views))
            return COHSM_ERR_FORMAT;
    }
    return COHSM_OK;
}

static int cohsm__tables_sound(const cohsm_maps *m)
{
    uint32_t i, n = m->head.map_count;
    const float *l = m->locations;

    for (i = 0; m->head.order_words && i < n; i++)
        if ((n <= 65536 ? cohsm__half_word(m->order, i) : m->order[i]) >= n) return 0;
    for (i = 0; m->head.location_words && i < n; i++, l += 4)
        if (!cohsm__finite3(l) || l[3] != (m->head.positional ? 1.0f : 0.0f)) return 0;
    return 1;
}

/* The object for a block of a file, everything in it checked. Takes the memory over, or frees it where it fails. */
static cohsm_result cohsm__open_block(const cohsm__allocator *a, cohsm__part part, cohsm__memory block,
                                      cohsm_maps **out)
{
    cohsm_maps *m;
    cohsm_result result = cohsm__maps_make(a, block, &m);

    if (result != COHSM_OK) return result;
    result = cohsm__tables_sound(m) ? cohsm__check_lists(m, part) : COHSM_ERR_FORMAT;
    if (result == COHSM_OK) *out = m;
    else cohsm_free(m);
    return result;
}

static cohsm_result cohsm__open_plain(const uint8_t *data, size_t size, const cohsm__allocator *a,
                                      const cohsm__part *part, cohsm_maps **out)
{
    cohsm__header h;
    cohsm__memory block;

    if (size < sizeof h) return COHSM_ERR_FORMAT;
    memcpy(&h, data, sizeof h);
    cohsm__host_words((uint32_t *)(void *)&h, COHSM__HEADER_WORDS);
    if (!cohsm__header_sound(&h) || size != 4 * (size_t)h.words) return COHSM_ERR_FORMAT;
    block = cohsm__take_block(a, h.words);
    if (!block.words) return COHSM_ERR_ALLOC;
    memcpy(block.words, data, size);
    cohsm__host_words(block.words, h.words);
    if (cohsm__block_crc(block.words, h.words) != h.crc) {
        cohsm__free(a, block.memory);
        return COHSM_ERR_FORMAT;
    }
    return cohsm__open_block(a, *part, block, out);
}

/* ---- >>pack: the entropy-coded file ---- */

/* The packed file:

     "DCSP", format, size of the file, the most segments in one list           4 words
     header of the plain block, then its locations, as they are
     lists, coded (most segments 0: the rest of the plain block as it is)

   The order table is derived. A list is coded as the first views of its segments, their depths, and how many go into
   each block; everything else in it follows, because blocks are written in one way only (see cohsm__plan_block). Every
   decision is a bit, coded with the adaptive probability of its context, and contexts come from the lists of the pixels
   to the left, above, and above to either side. Range coder after Martin, "Range encoding", 1979, on bits. */

enum {
    COHSM__PACK_MAGIC = 0x50534344,     /* "DCSP" */
    COHSM__PACK_FORMAT = 1,
    COHSM__PACK_HEADER = 16,            /* bytes */
    COHSM__PACK_MULTIPLE = 64           /* of the file's size: the most memory that opening asks for */
};

typedef uint16_t cohsm__prob;           /* of a 1, in 1/65536 */

/* Both directions in one: each step takes a bit to code and returns the bit coded, so that encoder and decoder are
   the same lines of code and cannot differ. */
typedef struct cohsm__coder {
    uint8_t       *out;                 /* NULL: decoding */
    const uint8_t *in;
    size_t         at, size;
    uint32_t       low, range, code;
    int            full;                /* the encoder ran out of room */
} cohsm__coder;

static void cohsm__coder_byte(cohsm__coder *c)
{
    if (c->out) {
        if (c->at < c->size) c->out[c->at++] = (uint8_t)(c->low >> 24);
        else c->full = 1;
        c->low <<= 8;
    } else c->code = c->code << 8 | (c->at < c->size ? c->in[c->at++] : 0u);    /* zeros beyond the end */
    c->range <<= 8;
}

static void cohsm__coder_start(cohsm__coder *c, uint8_t *out, const uint8_t *in, size_t size)
{
    int i;
    memset(c, 0, sizeof *c);
    c->out = out;
    c->in = in;
    c->size = size;
    for (i = 0; !out && i < 4; i++) cohsm__coder_byte(c);
    c->range = 0xffffffffu;
}

/* A 1 is the upper part of the range, a 0 the part below it. */
static void cohsm__coder_one(cohsm__coder *c, uint32_t zero)
{
    size_t i = c->at;
    c->range -= zero;
    if (!c->out) {
        c->code -= zero;
        return;
    }
    c->low += zero;
    if (c->low < zero)
        while (i && ++c->out[--i] == 0) {}          /* carry */
}

/* Probabilities stay within 31..65505 of 65536, so that neither part is ever empty. */
static inline uint32_t cohsm__code_bit(cohsm__coder *c, cohsm__prob *p, uint32_t bit)
{
    uint32_t zero = (c->range >> 12) * (4096u - (*p >> 4));
    if (!c->out) bit = c->code >= zero;
    if (bit) {
        cohsm__coder_one(c, zero);
        *p = (cohsm__prob)(*p + ((65536u - *p) >> 5));
    } else {
        c->range = zero;
        *p = (cohsm__prob)(*p - (*p >> 5));
    }
    while (c->range < 1u << 24) cohsm__coder_byte(c);
    return bit;
}

/* A number of this many bits, high bits first; each prefix has a probability of its own. */
static uint32_t cohsm__code_tree(cohsm__coder *c, cohsm__prob *p, uint32_t bits, uint32_t value)
{
    uint32_t node = 1;
    while (bits--) node = node << 1 | cohsm__code_bit(c, p + node, value >> bits & 1u);
    for (bits = 1; bits <= node >> 1; bits <<= 1) {}
    return node - bits;
}

/* Bits without a model. */
static uint32_t cohsm__code_raw(cohsm__coder *c, uint32_t bits, uint32_t value)
{
    uint32_t out = 0, bit;
    while (bits--) {
        c->range >>= 1;
        bit = c->out ? value >> bits & 1u : c->code >= c->range;
        if (bit) {
            c->range <<= 1;
            cohsm__coder_one(c, c->range >> 1);
        }
        while (c->range < 1u << 24) cohsm__coder_byte(c);
        out = out << 1 | bit;
    }
    return out;
}

/* Bits of x: 0 for 0, 1 for 1, 2 for 2 and 3, 3 for 4 to 7, ... */
static uint32_t cohsm__length(uint32_t x)
{
    x |= x >> 1;
    x |= x >> 2;
    x |= x >> 4;
    x |= x >> 8;
    return cohsm__popcount(x | x >> 16);
}

/* A number below 2^31: its length, then the bits below the leading one, of which the first is modelled. */
enum { COHSM__NUMBER = 64 };                    /* probabilities that one takes */

static uint32_t cohsm__code_number(cohsm__coder *c, cohsm__prob *p, uint32_t value)
{
    uint32_t bits = cohsm__code_tree(c, p, 5, cohsm__length(value)), low;
    if (bits < 2) return bits;
    low = cohsm__code_bit(c, p + 32 + bits, value >> (bits - 2u) & 1u) << (bits - 2u);
    if (bits > 2) low |= cohsm__code_raw(c, bits - 2u, value);
    return 1u << (bits - 1u) | low;
}

/* One list, taken apart. */
typedef struct cohsm__strip {
    uint32_t        count;              /* 0: there is no such pixel */
    cohsm__segment *s;                  /* hi: the grid value at or below an exact depth; else lo = hi */
    uint32_t       *breaks;             /* bit COHSM__MARGIN + i: a segment begins at view i > 0 */
} cohsm__strip;

enum { COHSM__LEFT, COHSM__UP, COHSM__UP_LEFT, COHSM__UP_RIGHT, COHSM__SELF, COHSM__STRIPS };
enum { COHSM__MARGIN = 32, COHSM__REACH = 2, COHSM__NEAR = 1 << (2 * COHSM__REACH + 1), COHSM__RUNS = 8,
       COHSM__BREAK_WORDS = (COHSM__MARGIN + 65536 + COHSM__REACH) / 32 + 2 };

typedef struct cohsm__odds {
    cohsm__prob hot[COHSM__NEAR * COHSM__NEAR * 3 * COHSM__RUNS];
    cohsm__prob cold[32 * 32], cold_length[32 * COHSM__NUMBER];
    cohsm__prob exact[3], repeat[128], left[64], up[8], below[16], error[32 * COHSM__NUMBER];
    cohsm__prob more[16 * 64];
    uint32_t breaks[COHSM__STRIPS][COHSM__BREAK_WORDS];     /* of the strips */
} cohsm__odds;

typedef struct cohsm__packer {
    cohsm__coder  c;
    cohsm__odds *m;
    cohsm__strip  strip[COHSM__STRIPS];
    cohsm__segment *segments;                   /* memory of the strips, then of taken */
    uint32_t      longest, width, views;        /* views of the chunk; width: words of strip.breaks */
    cohsm__grid   grid;
    uint32_t     *list;                         /* one list on its way out of the decoder */
    uint8_t      *taken;                        /* segments in each block of strip[COHSM__SELF] */
    int           bad;                          /* the decoder met what no encoder writes */
} cohsm__packer;

static uint32_t cohsm__grid_depth(uint32_t value, uint32_t grid)
{
    return value < grid ? value * 65535u / grid : (uint32_t)COHSM__INFINITE;
}

static void cohsm__strip_clear(cohsm__strip *t)
{
    uint32_t i;
    for (i = 1; i < t->count; i++) t->breaks[(COHSM__MARGIN + t->s[i].first) >> 5] = 0;
    t->count = 0;
}

static void cohsm__strip_breaks(cohsm__strip *t)
{
    uint32_t i;
    for (i = 1; i < t->count; i++) cohsm__put_bits(t->breaks, COHSM__MARGIN + t->s[i].first, 1, 1);
}

/* Segments of one block appended to a strip. */
static void cohsm__strip_block(const cohsm__packer *p, cohsm__strip *t, const uint32_t *block, uint32_t first)
{
    uint64_t marks = cohsm__marks(block);
    uint32_t n = cohsm__popcount(marks), bucket = 0, j, code, exact_at;
    cohsm__fields f = cohsm__block_fields(block, n);
    uint32_t ones = (1u << f.bits) - 1u;

    for (j = 0, exact_at = f.exact_at; j < n; marks >>= 1) {
        cohsm__segment *s = &t->s[t->count];
        if (!(marks & 1u)) {
            bucket++;
            continue;
        }
        s->first = (uint16_t)(first + (bucket << f.k) + cohsm__bits(block, COHSM__LOW_AT + j * f.k, f.k));
        code = cohsm__bits(block, f.codes_at + j * f.bits, f.bits);
        s->exact = code == ones;
        if (s->exact) {
            code = cohsm__bits(block, exact_at, 16);
            exact_at += 16;
        } else if (f.palette) code = cohsm__bits(block, f.palette_at + 8 * code, 8);
        else code = code + 1u == ones ? p->grid.top : code + (block[0] & 255u);
        s->lo = (uint16_t)(s->exact ? code : cohsm__min_u32(code, p->grid.top));
        s->hi = (uint16_t)(s->exact ? cohsm__grid_below(code, p->grid.top) : s->lo);
        t->count++;
        j++;
    }
}

/* Where the lists of a block are. The decoder reads what it wrote. */
typedef struct cohsm__lists { const uint32_t *lookup, *directories, *lines; } cohsm__lists;

static cohsm__lists cohsm__lists_of(const cohsm__header *h, const uint32_t *words)
{
    cohsm__lists l;
    l.lookup = words + COHSM__HEADER_WORDS + h->order_words + h->location_words;
    l.directories = l.lookup + h->lookup_words;
    l.lines = l.directories + h->directory_words;
    return l;
}

static void cohsm__strip_constant(const cohsm__packer *p, cohsm__strip *t, uint32_t depth)
{
    uint32_t value = cohsm__grid_above(depth, p->grid.top);
    t->s[0].first = 0;
    t->s[0].exact = cohsm__grid_depth(value, p->grid.top) != depth;
    t->s[0].lo = (uint16_t)(t->s[0].exact ? depth : value);
    t->s[0].hi = (uint16_t)(t->s[0].exact ? cohsm__grid_below(depth, p->grid.top) : value);
    t->count = 1;
}

/* A list as a strip; taken may be NULL. */
static void cohsm__strip_read(const cohsm__packer *p, cohsm__strip *t, const cohsm__lists *l, size_t index,
                              uint8_t *taken)
{
    uint32_t entry = l->lookup[index], b, before;
    const uint32_t *directory = l->directories + entry;

    cohsm__strip_clear(t);
    if (entry & COHSM__CONSTANT) cohsm__strip_constant(p, t, entry & 0xffffu);
    else
        for (b = 0; b < cohsm__block_count(directory); b++) {
            before = t->count;
            cohsm__strip_block(p, t, cohsm__block_at(directory, l->lines, b),
                               b ? cohsm__block_first(directory, b) : 0u);
            if (taken) taken[b] = (uint8_t)(t->count - before);
        }
    cohsm__strip_breaks(t);
}

/* Breaks of a strip from view - COHSM__REACH on, as bits, 33 of them or more. */
static uint64_t cohsm__near(const cohsm__strip *t, uint32_t view)
{
    return cohsm__window(t->breaks, COHSM__MARGIN + view - COHSM__REACH);
}

/* The first view at or after this one that has a break of either neighbour within reach, at most p->views. */
static uint32_t cohsm__next_hot(const cohsm__packer *p, uint32_t view)
{
    const uint32_t *a = p->strip[COHSM__LEFT].breaks, *b = p->strip[COHSM__UP].breaks;
    uint32_t at = COHSM__MARGIN + view + COHSM__REACH, i = at >> 5, word;

    if (i >= p->width) return p->views;
    for (word = (a[i] | b[i]) >> (at & 31u) << (at & 31u); !word; word = a[i] | b[i])
        if (++i == p->width) return p->views;
    at = 32 * i + cohsm__popcount((word & (0u - word)) - 1u);
    return at - COHSM__MARGIN - COHSM__REACH;
}

/* Views next to a break of the left or the upper list are asked one by one. Returns the first that is not, or the one
   where the segment ends, with *ended. */
static uint32_t cohsm__code_hot(cohsm__packer *p, uint32_t first, uint32_t view, uint32_t next, int *ended)
{
    uint64_t left = cohsm__near(&p->strip[COHSM__LEFT], view), up = cohsm__near(&p->strip[COHSM__UP], view);
    uint64_t right = cohsm__near(&p->strip[COHSM__UP_RIGHT], view);
    uint32_t stop = cohsm__min_u32(p->views, view + 33u - 2 * COHSM__REACH), run = cohsm__length(view - first), l, u, r;
    cohsm__prob *odds;

    for (; view < stop; view++, left >>= 1, up >>= 1, right >>= 1) {
        l = (uint32_t)left & (COHSM__NEAR - 1u);
        u = (uint32_t)up & (COHSM__NEAR - 1u);
        r = (uint32_t)right & (COHSM__NEAR - 1u);
        if (!(l | u)) break;
        if ((view - first) >> run) run++;
        r = r >> COHSM__REACH & 1u ? 2u : r ? 1u : 0u;
        odds = p->m->hot + ((l * COHSM__NEAR + u) * 3u + r) * COHSM__RUNS + cohsm__min_u32(run, COHSM__RUNS) - 1u;
        *ended = (int)cohsm__code_bit(&p->c, odds, view == next);
        if (*ended) break;
    }
    return view;
}

/* Where the segment that began at first ends. The stretches between such views are asked as a whole, and then for the
   place. */
static uint32_t cohsm__code_next(cohsm__packer *p, uint32_t first, uint32_t next)
{
    uint32_t view = first + 1u, gap, hot;
    int ended = 0;

    for (;;) {
        view = cohsm__code_hot(p, first, view, next, &ended);
        if (ended || view >= p->views) return view;
        hot = cohsm__next_hot(p, view);
        if (hot == view) continue;
        gap = cohsm__length(hot - view);
        if (cohsm__code_bit(&p->c, p->m->cold + 32 * gap + cohsm__length(view - first), next < hot)) {
            next = view + cohsm__code_number(&p->c, p->m->cold_length + COHSM__NUMBER * gap, next - view);
            return cohsm__min_u32(next, hot - 1u);
        }
        view = hot;
    }
}

static void cohsm__code_breaks(cohsm__packer *p)
{
    cohsm__strip *t = &p->strip[COHSM__SELF];
    uint32_t count = t->count, i = 0, next;

    if (!p->c.out) t->s[0].first = 0;
    for (;;) {
        next = cohsm__code_next(p, t->s[i].first, p->c.out && i + 1 < count ? t->s[i + 1].first : p->views);
        if (next >= p->views) break;
        if (++i == p->longest) {
            p->bad = 1;
            break;
        }
        t->s[i].first = (uint16_t)next;
    }
    t->count = cohsm__min_u32(i + 1u, p->longest);
    if (!p->c.out) cohsm__strip_breaks(t);
}

/* The grid value that a strip has at a view; views are asked in rising sequence. */
static uint32_t cohsm__strip_value(const cohsm__strip *t, uint32_t *at, uint32_t view, uint32_t otherwise)
{
    if (!t->count) return otherwise;
    while (*at + 1u < t->count && t->s[*at + 1u].first <= view) ++*at;
    return t->s[*at].hi;
}

/* The median of left, up and left + up - up_left: an edge, or else a plane, through three known neighbours. */
static uint32_t cohsm__predict(uint32_t left, uint32_t up, uint32_t corner)
{
    uint32_t least = cohsm__min_u32(left, up), most = cohsm__max_u32(left, up);
    return corner >= most ? least : corner <= least ? most : left + up - corner;
}

/* What is known when a segment's value is coded: of the neighbours at its middle, and of the two segments before. */
typedef struct cohsm__around { uint32_t left, up, corner, before[2], history, run; } cohsm__around;

/* In turn: the value before last, as where two surfaces flicker; the left and the upper one's; a correction. */
static uint32_t cohsm__code_value(cohsm__packer *p, const cohsm__around *a, uint32_t value)
{
    cohsm__odds *m = p->m;
    cohsm__coder *c = &p->c;
    uint32_t last = a->before[1], h = a->history, guess, below, error, spread;

    if (cohsm__code_bit(c, m->repeat + ((a->left == last ? 1u : 0u) | (a->up == last ? 2u : 0u) | (h & 7u) << 2 |
                                        (a->run == 1 ? 32u : 0u) | (a->before[0] == last ? 64u : 0u)), value == last))
        return last;
    if (a->left != last && cohsm__code_bit(c, m->left + ((a->up == a->left ? 1u : 0u) | (h & 14u) << 1 |
                                                         (a->before[0] == a->left ? 32u : 0u)), value == a->left))
        return a->left;
    if (a->up != last && a->up != a->left && cohsm__code_bit(c, m->up + (h & 7u), value == a->up)) return a->up;
    guess = cohsm__predict(a->left, a->up, a->corner);
    spread = cohsm__length(cohsm__max_u32(a->left, a->up) - cohsm__min_u32(a->left, a->up));
    below = cohsm__code_bit(c, m->below + spread, value < guess);
    error = cohsm__code_number(c, m->error + COHSM__NUMBER * (2 * spread + below),
                               below ? guess - value : value - guess);
    return below ? guess - cohsm__min_u32(error, guess) : guess + cohsm__min_u32(error, p->grid.top - guess);
}

static void cohsm__code_values(cohsm__packer *p)
{
    cohsm__strip *t = &p->strip[COHSM__SELF];
    uint32_t at[COHSM__SELF], i, end, middle, exact = 0;
    cohsm__around a;

    memset(at, 0, sizeof at);
    memset(&a, 0, sizeof a);
    for (i = 0; i < t->count; i++) {
        cohsm__segment *s = &t->s[i];
        end = cohsm__segment_end(t->s, i, t->count, p->views);
        middle = (s->first + end) / 2u;
        a.run = end - s->first;
        a.up = cohsm__strip_value(&p->strip[COHSM__UP], at + COHSM__UP, middle, a.before[1]);
        a.left = cohsm__strip_value(&p->strip[COHSM__LEFT], at + COHSM__LEFT, middle, a.up);
        if (!p->strip[COHSM__UP].count) a.up = a.left;
        a.corner = cohsm__strip_value(&p->strip[COHSM__UP_LEFT], at + COHSM__UP_LEFT, middle, a.up);
        exact = cohsm__code_bit(&p->c, p->m->exact + (a.run > 1 ? 0u : 1u + exact), s->exact);
        if (exact) {
            s->lo = (uint16_t)cohsm__code_raw(&p->c, 16, s->lo);
            s->hi = (uint16_t)cohsm__grid_below(s->lo, p->grid.top);
        } else {
            s->hi = s->lo = (uint16_t)cohsm__code_value(p, &a, s->lo);
            a.history = a.history << 1 | (s->hi == a.before[1]);
        }
        s->exact = (uint16_t)exact;
        a.before[1] = a.before[0];
        a.before[0] = s->hi;
    }
}

/* How many of the segments fit into a block without a palette, as cohsm__plan_take would find. */
static uint32_t cohsm__fitting(const cohsm__segment *s, uint32_t count, uint32_t grid, uint32_t views)
{
    uint32_t n, least = grid, most = 0, exact = 0, k = 0, bits = 2, span;

    for (n = 0; n < count && n < COHSM__MARKS; n++) {
        span = cohsm__segment_end(s, n, count, views) - s[0].first;
        if (s[n].exact) exact++;
        else if (s[n].lo < grid) {
            least = cohsm__min_u32(least, s[n].lo);
            most = cohsm__max_u32(most, s[n].lo);
        }
        while (n + 1u + ((span - 1u) >> k) > COHSM__MARKS) k++;
        while (least < most && (1u << bits) - 2u < most - least + 1u) bits++;
        if (COHSM__LOW_AT + (n + 1u) * (k + bits) + 16u * exact > COHSM__BLOCK_BITS) break;
    }
    return n;
}

/* How many segments each block takes: more than fit by their values, since the planner went by intervals. */
static uint32_t cohsm__code_blocks(cohsm__packer *p)
{
    const cohsm__strip *t = &p->strip[COHSM__SELF];
    uint32_t i, n, blocks, left;

    for (i = 0, blocks = 0; i < t->count; i += p->taken[blocks++]) {
        left = t->count - i;
        n = cohsm__fitting(t->s + i, left, p->grid.top, p->views);
        left = cohsm__min_u32(left, COHSM__MARKS);
        if (n < left)
            n += cohsm__code_tree(&p->c, p->m->more + 64 * (n / 4u), 6, p->c.out ? p->taken[blocks] - n : 0);
        p->taken[blocks] = (uint8_t)cohsm__min_u32(n, left);
    }
    return blocks;
}

/* The plan of exactly n segments; last: as those of a tail. */
static int cohsm__plan_exactly(cohsm__plan *plan, const cohsm__segment *s, uint32_t n, const cohsm__grid *grid,
                               uint32_t end, int last)
{
    cohsm__plan other;

    cohsm__plan_start(plan);
    for (; plan->n + 1u < n; plan->n++) {
        const cohsm__segment *t = &s[plan->n];
        if (t->exact) plan->exact++;
        else if (t->lo < grid->top) {
            plan->least_hi = cohsm__min_u32(plan->least_hi, t->hi);
            plan->greatest_lo = cohsm__max_u32(plan->greatest_lo, t->lo);
        }
    }
    if (!cohsm__plan_take(plan, s, grid, end)) return 0;
    other = *plan;
    if (last && !plan->palette && cohsm__plan_palette(&other, s, grid) && other.size < plan->size) *plan = other;
    return 1;
}

/* The decoded list as the builder would keep it, see cohsm__write_list. 0: no builder wrote this. */
static int cohsm__strip_write(const cohsm__packer *p, uint32_t blocks)
{
    const cohsm__segment *s = p->strip[COHSM__SELF].s;
    uint32_t count = p->strip[COHSM__SELF].count, i, n, end, *block = p->list + (blocks + 1u) / 2u;
    cohsm__plan plan;

    if (blocks > cohsm__blocks_bound(count)) return 0;
    memset(p->list, 0, 4 * cohsm__list_bound(count));
    p->list[0] = blocks;
    for (i = 0; i < blocks; i++, s += n, count -= n, block += COHSM__BLOCK_WORDS) {
        n = p->taken[i];
        end = cohsm__segment_end(s, n - 1u, count, p->views);
        if (!cohsm__plan_exactly(&plan, s, n, &p->grid, end, n == count)) return 0;
        if (i) cohsm__put_bits(p->list, 16u * i, 16, s[0].first);
        cohsm__write_block(block, s, &plan, &p->grid);
    }
    return 1;
}

/* The decoded list, laid where it belongs, if there is room. */
static int cohsm__strip_lay(const cohsm__packer *p, const cohsm__header *h, uint32_t blocks, cohsm__layout *l,
                            uint32_t *entry)
{
    const cohsm__segment *s = p->strip[COHSM__SELF].s;
    cohsm__layout dry = *l;

    if (p->strip[COHSM__SELF].count == 1) {
        *entry = COHSM__CONSTANT | (s->exact ? s->lo : cohsm__grid_depth(s->lo, p->grid.top));
        return 1;
    }
    if (!cohsm__strip_write(p, blocks)) return 0;
    dry.directories = dry.lines = NULL;
    cohsm__lay_raw(&dry, entry, p->list);
    if (dry.directory_words > h->directory_words || dry.line_count > h->line_words / COHSM__BLOCK_WORDS) return 0;
    cohsm__lay_raw(l, entry, p->list);
    return 1;
}

static void cohsm__slide(cohsm__packer *p)
{
    cohsm__strip *t = p->strip, spare = t[COHSM__UP_LEFT];
    t[COHSM__UP_LEFT] = t[COHSM__UP];
    t[COHSM__UP] = t[COHSM__UP_RIGHT];
    t[COHSM__UP_RIGHT] = t[COHSM__LEFT];
    t[COHSM__LEFT] = t[COHSM__SELF];
    t[COHSM__SELF] = spare;
}

/* Strips around a pixel of the range; index: of its lookup entry. Within a row all but the upper right one are at
   hand. */
static void cohsm__look_around(cohsm__packer *p, const cohsm__header *h, uint32_t pixel, size_t index,
                               const cohsm__lists *l)
{
    uint32_t m = h->map_size, x = (h->pixel_begin + pixel) % m;
    cohsm__strip *t = p->strip;

    cohsm__slide(p);
    cohsm__strip_clear(&t[COHSM__SELF]);
    if (x == 0 || pixel == 0) {
        cohsm__strip_clear(&t[COHSM__LEFT]);
        cohsm__strip_clear(&t[COHSM__UP_LEFT]);
        if (pixel >= m) cohsm__strip_read(p, &t[COHSM__UP], l, index - m, NULL);
        else cohsm__strip_clear(&t[COHSM__UP]);
    }
    if (x + 1 < m && pixel + 1 >= m) cohsm__strip_read(p, &t[COHSM__UP_RIGHT], l, index + 1u - m, NULL);
    else cohsm__strip_clear(&t[COHSM__UP_RIGHT]);
}

/* Codes all lists of a block. The decoder writes them and the lookup into out, which is words with its header.
   COHSM_ERR_FORMAT: no builder wrote this, or there is no room for it. */
static cohsm_result cohsm__code_lists(cohsm__packer *p, const cohsm__header *h, const uint32_t *words, uint32_t *out,
                                      cohsm__part part)
{
    cohsm__lists lists = cohsm__lists_of(h, words);
    cohsm__layout layout;
    uint32_t range = h->pixel_end - h->pixel_begin, pixel, blocks, *lookup = NULL;
    size_t i;

    if (out) cohsm__layout_into(&layout, h, out, &lookup);
    for (i = 0; i < h->lookup_words; i++) {
        if (cohsm__cancelled(&part, i, h->lookup_words, COHSM__LISTS_CODED)) return COHSM_ERR_CANCELLED;
        pixel = (uint32_t)(i % range);
        if (pixel == 0) {
            p->views = cohsm__min_u32(h->view_count - (uint32_t)(i / range) * COHSM__CHUNK, COHSM__CHUNK);
            p->width = (COHSM__MARGIN + p->views + COHSM__REACH) / 32u + 2u;
        }
        cohsm__look_around(p, h, pixel, i, &lists);
        if (!out) cohsm__strip_read(p, &p->strip[COHSM__SELF], &lists, i, p->taken);
        cohsm__code_breaks(p);
        cohsm__code_values(p);
        blocks = cohsm__code_blocks(p);
        if (p->bad || p->c.full) return COHSM_ERR_FORMAT;
        if (out && !cohsm__strip_lay(p, h, blocks, &layout, &lookup[i])) return COHSM_ERR_FORMAT;
    }
    return COHSM_OK;
}

/* Segments of the longest list. */
static uint32_t cohsm__longest(const cohsm_maps *m)
{
    uint32_t longest = 1, n, b;
    size_t i;
    for (i = 0; i < m->head.lookup_words; i++) {
        const uint32_t *directory = m->directories + m->lookup[i];
        if (m->lookup[i] & COHSM__CONSTANT) continue;
        for (b = 0, n = 0; b < cohsm__block_count(directory); b++)
            n += cohsm__popcount(cohsm__marks(cohsm__block_at(directory, m->lines, b)));
        longest = cohsm__max_u32(longest, n);
    }
    return longest;
}

/* Memory of the work on a block: strips, and the order table's cells. */
static uint64_t cohsm__pack_work(const cohsm__header *h, uint32_t longest)
{
    return (uint64_t)longest * (COHSM__STRIPS * sizeof(cohsm__segment) + 1) + 4 * (uint64_t)cohsm__list_bound(longest) +
           (h->order_words ? 4 * (uint64_t)h->map_count : 0);
}

static int cohsm__packer_make(cohsm__packer *p, const cohsm__allocator *a, const cohsm__header *h, uint32_t longest)
{
    cohsm__prob *probs;
    size_t i;

    memset(p, 0, sizeof *p);
    p->longest = longest;
    p->grid = cohsm__grid_of(h->depth_bits, h->map_size);
    p->m = (cohsm__odds *)cohsm__alloc(a, sizeof *p->m);
    p->segments = (cohsm__segment *)cohsm__alloc_array(a, longest, COHSM__STRIPS * sizeof(cohsm__segment) + 1);
    p->list = (uint32_t *)cohsm__alloc_array(a, cohsm__list_bound(longest), 4);
    if (!p->m || !p->segments || !p->list) return 0;
    memset(p->m->breaks, 0, sizeof p->m->breaks);
    probs = p->m->hot;
    for (i = 0; i < offsetof(cohsm__odds, breaks) / sizeof *probs; i++) probs[i] = 0x8000u;
    for (i = 0; i < COHSM__STRIPS; i++) {
        p->strip[i].breaks = p->m->breaks[i];
        p->strip[i].s = p->segments + i * longest;
    }
    p->taken = (uint8_t *)(p->segments + COHSM__STRIPS * (size_t)longest);
    return 1;
}

static void cohsm__packer_free(cohsm__packer *p, const cohsm__allocator *a)
{
    cohsm__free(a, p->m);
    cohsm__free(a, p->segments);
    cohsm__free(a, p->list);
}

static size_t cohsm__pack_head(const cohsm__header *h)
{
    return COHSM__PACK_HEADER + 4 * ((size_t)COHSM__HEADER_WORDS + h->location_words);
}

/* The words that are not coded, in place, and the order table. */
static cohsm_result cohsm__unpack_head(const uint8_t *data, const cohsm__allocator *a, const cohsm__header *h,
                                       uint32_t *words)
{
    size_t i, gap = COHSM__HEADER_WORDS + (size_t)h->order_words;
    uint32_t *cells;

    data += COHSM__PACK_HEADER;
    for (i = 0; i < COHSM__HEADER_WORDS; i++) words[i] = cohsm__get_u32(data + 4 * i);
    data += 4 * (size_t)COHSM__HEADER_WORDS;
    for (i = 0; i < h->location_words; i++) words[gap + i] = cohsm__get_u32(data + 4 * i);
    if (!h->order_words) return COHSM_OK;
    cells = (uint32_t *)cohsm__alloc_array(a, h->map_count, 4);
    if (!cells) return COHSM_ERR_ALLOC;
    cohsm__order_cells(cells, h->side, (cohsm_order)h->order);
    cohsm__write_order(words + COHSM__HEADER_WORDS, cells, h->map_count);
    cohsm__free(a, cells);
    return COHSM_OK;
}

static cohsm_result cohsm__unpack_words(const uint8_t *data, size_t size, const cohsm__allocator *a,
                                        cohsm__part part, const cohsm__header *h, uint32_t *words)
{
    cohsm__packer p;
    size_t head = cohsm__pack_head(h);
    cohsm_result result = cohsm__unpack_head(data, a, h, words);

    if (result != COHSM_OK) return result;
    if (!cohsm__packer_make(&p, a, h, cohsm__get_u32(data + 12))) result = COHSM_ERR_ALLOC;
    else {
        cohsm__coder_start(&p.c, NULL, data + head, size - head);
        result = cohsm__code_lists(&p, h, words, words, part);
        if (result == COHSM_OK && cohsm__block_crc(words, h->words) != h->crc) result = COHSM_ERR_FORMAT;
    }
    cohsm__packer_free(&p, a);
    return result;
}

/* A packed file: 16 bytes or more, its magic known; all else may be hostile. Memory asked for: COHSM__PACK_MULTIPLE
   bytes a byte of file, and below 256 KB for the probabilities and the object. */
static cohsm_result cohsm__unpack(const uint8_t *data, size_t size, const cohsm__allocator *a, const cohsm__part *part,
                                  cohsm_maps **out)
{
    const uint8_t *inner = data + COHSM__PACK_HEADER;
    cohsm__header h;
    cohsm__memory block;
    uint32_t longest;
    cohsm_result result;

    if (cohsm__get_u32(data + 4) != COHSM__PACK_FORMAT) return COHSM_ERR_VERSION;
    if (cohsm__get_u32(data + 8) != size || size < COHSM__PACK_HEADER + sizeof h) return COHSM_ERR_FORMAT;
    if (cohsm__get_u32(inner) != COHSM__MAGIC) return COHSM_ERR_FORMAT;
    if (cohsm__get_u32(inner + 4) != COHSM__FORMAT) return COHSM_ERR_VERSION;
    longest = cohsm__get_u32(data + 12);
    if (longest == 0) return cohsm__open_plain(inner, size - COHSM__PACK_HEADER, a, part, out);
    memcpy(&h, inner, sizeof h);
    cohsm__host_words((uint32_t *)(void *)&h, COHSM__HEADER_WORDS);
    if (!cohsm__header_sound(&h) || longest > COHSM__CHUNK || longest > h.view_count || cohsm__pack_head(&h) > size ||
        4 * (uint64_t)h.words + cohsm__pack_work(&h, longest) > COHSM__PACK_MULTIPLE * (uint64_t)size)
        return COHSM_ERR_FORMAT;
    block = cohsm__take_block(a, h.words);
    if (!block.words) return COHSM_ERR_ALLOC;
    result = cohsm__unpack_words(data, size, a, cohsm__part_of(part, 0.0f, 0.9f), &h, block.words);
    if (result == COHSM_OK) return cohsm__open_block(a, cohsm__part_of(part, 0.9f, 1.0f), block, out);
    cohsm__free(a, block.memory);
    return result;
}

static void cohsm__pack_begin(uint8_t *data, size_t size, uint32_t longest)
{
    cohsm__put_u32(data, COHSM__PACK_MAGIC);
    cohsm__put_u32(data + 4, COHSM__PACK_FORMAT);
    cohsm__put_u32(data + 8, (uint32_t)size);
    cohsm__put_u32(data + 12, longest);
}

/* Codes into data; COHSM_ERR_FORMAT where it would reach room. Filled up with zeros to what opening has to see before
   it asks for memory. */
static cohsm_result cohsm__pack_coded(cohsm__packer *p, const cohsm_maps *m, const cohsm__part *part, uint8_t *data,
                                      size_t room, size_t *size)
{
    const cohsm__header *h = &m->head;
    size_t head = cohsm__pack_head(h), i, gap = COHSM__HEADER_WORDS + (size_t)h->order_words;
    uint64_t least = 4 * (uint64_t)h->words + cohsm__pack_work(h, p->longest);
    cohsm_result result;

    least = (least + COHSM__PACK_MULTIPLE - 1u) / COHSM__PACK_MULTIPLE;
    if (least >= room) return COHSM_ERR_FORMAT;
    for (i = 0; i < COHSM__HEADER_WORDS; i++) cohsm__put_u32(data + COHSM__PACK_HEADER + 4 * i, m->words[i]);
    for (i = 0; i < h->location_words; i++)
        cohsm__put_u32(data + COHSM__PACK_HEADER + 4 * (COHSM__HEADER_WORDS + i), m->words[gap + i]);
    cohsm__coder_start(&p->c, data + head, NULL, room - head);
    result = cohsm__code_lists(p, h, m->words, NULL, cohsm__part_of(part, 0.0f, 0.5f));
    if (result != COHSM_OK) return result;
    for (i = 0; i < 4; i++) cohsm__coder_byte(&p->c);
    if (p->c.full) return COHSM_ERR_FORMAT;
    *size = head + p->c.at;
    if (*size < least) {
        memset(data + *size, 0, (size_t)least - *size);
        *size = (size_t)least;
    }
    cohsm__pack_begin(data, *size, p->longest);
    return COHSM_OK;
}

/* COHSM_ERR_FORMAT where data does not unpack to these maps: they are sound, but our builder did not write them. */
static cohsm_result cohsm__pack_check(const cohsm_maps *m, const cohsm__allocator *a, const cohsm__part *part,
                                      const uint8_t *data, size_t size)
{
    cohsm__part second = cohsm__part_of(part, 0.5f, 1.0f);
    cohsm_maps *copy;
    cohsm_result result = cohsm__unpack(data, size, a, &second, &copy);

    if (result != COHSM_OK) return result;
    if (memcmp(copy->words, m->words, 4 * (size_t)m->head.words) != 0) result = COHSM_ERR_FORMAT;
    cohsm_free(copy);
    return result;
}

COHSM_DEF cohsm_result cohsm_pack(const cohsm_maps *maps, const cohsm_desc *desc, void **data, size_t *size)
{
    cohsm__allocator a;
    cohsm__part part;
    cohsm__packer p;
    uint8_t *big, *packed = NULL;
    size_t plain, coded = 0;
    uint64_t whole;
    cohsm_result result;

    if (!maps || !data || !size) return COHSM_ERR_ARGUMENT;
    if (!cohsm__services_of(desc, &a, &part)) return COHSM_ERR_DESC;
    whole = 4 * (uint64_t)maps->head.words + COHSM__PACK_HEADER;
    if (whole > 0xffffffffu) return COHSM_ERR_LIMIT;
    plain = (size_t)whole;
    big = (uint8_t *)cohsm__alloc(&a, plain);
    if (!big) return COHSM_ERR_ALLOC;
    if (cohsm__packer_make(&p, &a, &maps->head, cohsm__longest(maps)))
        result = cohsm__pack_coded(&p, maps, &part, big, plain, &coded);
    else result = COHSM_ERR_ALLOC;
    cohsm__packer_free(&p, &a);
    if (result == COHSM_OK) result = cohsm__pack_check(maps, &a, &part, big, coded);
    if (result == COHSM_ERR_FORMAT) {                   /* as it is */
        coded = plain;
        cohsm__pack_begin(big, plain, 0);
        result = cohsm_write(maps, big + COHSM__PACK_HEADER, plain - COHSM__PACK_HEADER);
    }
    if (result == COHSM_OK) {
        packed = (uint8_t *)cohsm__alloc(&a, coded);
        if (packed) memcpy(packed, big, coded);
        else result = COHSM_ERR_ALLOC;
    }
    cohsm__free(&a, big);
    if (result != COHSM_OK) return result;
    *data = packed;
    *size = coded;
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_open(const void *data, size_t size, const cohsm_desc *desc, cohsm_maps **out)
{
    const uint8_t *bytes = (const uint8_t *)data;
    cohsm__allocator a;
    cohsm__part part;

    if (!data || !out) return COHSM_ERR_ARGUMENT;
    if (!cohsm__services_of(desc, &a, &part)) return COHSM_ERR_DESC;
    if (size < 16) return COHSM_ERR_FORMAT;
    if (cohsm__get_u32(bytes) == COHSM__PACK_MAGIC) return cohsm__unpack(bytes, size, &a, &part, out);
    if (cohsm__get_u32(bytes) != COHSM__MAGIC) return COHSM_ERR_FORMAT;
    if (cohsm__get_u32(bytes + 4) != COHSM__FORMAT) return COHSM_ERR_VERSION;
    return cohsm__open_plain(bytes, size, &a, &part, out);
}

/* ---- >>sampling: BRDFs ----------------------------------------------------------------------------------------- */

#define COHSM__PI 3.14159265f
#define COHSM__BELOW_1 0.99999994f

typedef struct cohsm__cosine_lobe { /* scale max(0, axis . wi)^exponent */
    cohsm__v3 axis, scale;
    float     exponent;
} cohsm__cosine_lobe;

typedef struct cohsm__surface {  /* a material at one point, all directions in the frame t, b, n */
    cohsm__v3 t, b, n, wo;
    cohsm__v3 diffuse, f0;
    float     alpha;             /* GGX; 0: cosine lobes */
    uint32_t  lobe_count;
    cohsm__cosine_lobe lobes[COHSM_MAX_LOBES];
    float     lobe_share[COHSM_MAX_LOBES]; /* roulette among them, the sum is 1 */
    float     diffuse_share;     /* roulette between the diffuse part and them: k_d of the paper */
    float     peak;              /* largest density of the BRDF samples, roughly, 1/sr */
    int       black;
} cohsm__surface;

typedef struct cohsm__response { /* f and density for one wi, the two parts apart */
    cohsm__v3 diffuse, specular;
    float     diffuse_pdf, specular_pdf;
} cohsm__response;

static float cohsm__mean3(cohsm__v3 c) { return (c.x + c.y + c.z) * (1.0f / 3.0f); }
static float cohsm__clamp_unit(float u) { return u > 0.0f ? u < COHSM__BELOW_1 ? u : COHSM__BELOW_1 : 0.0f; }
static float cohsm__safe_sqrt(float x) { return x > 0.0f ? sqrtf(x) : 0.0f; }

static cohsm__v3 cohsm__to_frame(const cohsm__surface *s, cohsm__v3 w)
{
    return cohsm__v3_make(cohsm__v3_dot(w, s->t), cohsm__v3_dot(w, s->b), cohsm__v3_dot(w, s->n));
}

static cohsm__v3 cohsm__from_frame(cohsm__v3 t, cohsm__v3 b, cohsm__v3 n, cohsm__v3 w)
{
    return cohsm__v3_madd(cohsm__v3_madd(cohsm__v3_scale(t, w.x), b, w.y), n, w.z);
}

static float cohsm__pow5(float x) { return x * x * (x * x) * x; }

static cohsm__v3 cohsm__schlick(cohsm__v3 f0, float cosine)
{
    float f = cohsm__pow5(1.0f - cosine);
    return cohsm__v3_madd(cohsm__v3_scale(f0, 1.0f - f), cohsm__v3_make(1.0f, 1.0f, 1.0f), f);
}

/* Inverse of cohsm__concentric. */
static void cohsm__disc_square(float x, float y, float *u, float *v)
{
    float r = sqrtf(x * x + y * y), a, b;
    if (fabsf(x) > fabsf(y)) {
        a = x > 0.0f ? r : -r;
        b = a * (4.0f / COHSM__PI) * cohsm__atan2(y / x, 1.0f);
    } else {
        b = y > 0.0f ? r : -r;
        a = r > 0.0f ? b * (4.0f / COHSM__PI) * cohsm__atan2(x / y, 1.0f) : 0.0f;
    }
    *u = cohsm__clamp_unit(0.5f * (a + 1.0f));
    *v = cohsm__clamp_unit(0.5f * (b + 1.0f));
}

static int cohsm__in3(const float *p, float low, float high)
{
    int i;
    for (i = 0; i < 3; i++)
        if (!cohsm__finite(p[i]) || p[i] < low || p[i] > high) return 0;
    return 1;
}


static int cohsm__is_unit(const float *p)
{
    cohsm__v3 v = cohsm__v3_load(p);
    return cohsm__v3_finite(v) && fabsf(cohsm__v3_dot(v, v) - 1.0f) <= 2e-3f;
}

static int cohsm__material_valid(const cohsm_material *m)
{
    uint32_t i;
    if ((unsigned)m->type > (unsigned)COHSM_BRDF_METAL_ROUGH || !cohsm__in3(m->diffuse, 0.0f, 1.0f)) return 0;
    if (m->type == COHSM_BRDF_PHONG)
        return cohsm__in3(m->specular, 0.0f, 1.0f) && cohsm__in(m->exponent, 0.0f, 1e5f);
    if (m->type == COHSM_BRDF_METAL_ROUGH)
        return cohsm__in(m->metallic, 0.0f, 1.0f) && cohsm__in(m->roughness, 0.0f, 1.0f);
    if (m->type != COHSM_BRDF_LAFORTUNE) return 1;
    if (m->lobe_count > COHSM_MAX_LOBES || (m->lobe_count && !m->lobes)) return 0;
    for (i = 0; i < m->lobe_count; i++)
        if (!cohsm__in3(m->lobes[i].axis, -10.0f, 10.0f) || !cohsm__in3(m->lobes[i].scale, 0.0f, 1e9f) ||
            !cohsm__in(m->lobes[i].exponent, 0.0f, 1e5f))
            return 0;
    return 1;
}

/* Adds a lobe about C wo and returns its albedo, roughly: that only steers the roulette. */
static float cohsm__add_lobe(cohsm__surface *s, cohsm__v3 c, float exponent, cohsm__v3 scale)
{
    cohsm__cosine_lobe *lobe = &s->lobes[s->lobe_count];
    cohsm__v3 a = cohsm__v3_mul(c, s->wo);
    float length = cohsm__v3_length(a), albedo;

    if (!(length > 0.0f)) return 0.0f;
    lobe->axis = cohsm__v3_scale(a, 1.0f / length);
    lobe->exponent = exponent;
    lobe->scale = cohsm__v3_scale(scale, exponent > 0.0f ? cohsm__pow(length, exponent) : 1.0f);
    albedo = cohsm__mean3(lobe->scale) * 2.0f * COHSM__PI / (exponent + 2.0f);
    albedo *= lobe->axis.z > 0.1f ? lobe->axis.z : 0.1f;
    if (!(albedo > 0.0f) || !cohsm__v3_finite(lobe->scale)) return 0.0f;
    s->lobe_share[s->lobe_count++] = albedo;
    return albedo;
}

static float cohsm__specular_init(cohsm__surface *s, const cohsm_material *m)
{
    cohsm__v3 base = cohsm__v3_load(m->diffuse);
    float sum = 0.0f;
    uint32_t i;

    if (m->type == COHSM_BRDF_METAL_ROUGH) {
        s->alpha = m->roughness * m->roughness > 0.002f ? m->roughness * m->roughness : 0.002f;
        s->f0 = cohsm__v3_make(0.04f, 0.04f, 0.04f);
        s->f0 = cohsm__v3_madd(cohsm__v3_scale(s->f0, 1.0f - m->metallic), base, m->metallic);
        s->diffuse = cohsm__v3_scale(base, 1.0f - m->metallic);
        s->lobe_count = 1;
        s->lobe_share[0] = sum = cohsm__mean3(cohsm__schlick(s->f0, s->wo.z));
    } else if (m->type == COHSM_BRDF_PHONG) {
        float norm = (m->exponent + 2.0f) / (2.0f * COHSM__PI);
        sum = cohsm__add_lobe(s, cohsm__v3_make(-1.0f, -1.0f, 1.0f), m->exponent,
                              cohsm__v3_scale(cohsm__v3_load(m->specular), norm));
    } else if (m->type == COHSM_BRDF_LAFORTUNE) {
        for (i = 0; i < m->lobe_count; i++)
            sum += cohsm__add_lobe(s, cohsm__v3_load(m->lobes[i].axis), m->lobes[i].exponent,
                                   cohsm__v3_load(m->lobes[i].scale));
    }
    return sum;
}

static void cohsm__surface_init(cohsm__surface *s, const cohsm_material *m, cohsm__v3 n, const float *tangent,
                                cohsm__v3 wo)
{
    cohsm__v3 t = tangent ? cohsm__v3_load(tangent) : cohsm__v3_make(0.0f, 0.0f, 0.0f);
    float specular, diffuse;
    uint32_t i;

    s->n = cohsm__v3_normalize(n);
    t = cohsm__v3_madd(t, s->n, -cohsm__v3_dot(t, s->n));
    if (cohsm__v3_dot(t, t) > 1e-6f) {
        s->t = cohsm__v3_normalize(t);
        s->b = cohsm__v3_cross(s->n, s->t);
    } else {
        cohsm__v3_basis(s->n, &s->t, &s->b);
    }
    s->wo = cohsm__to_frame(s, cohsm__v3_normalize(wo));
    if (s->wo.z < 1e-3f) {       /* the eye may be below the horizon of an interpolated normal */
        s->wo.z = 1e-3f;
        s->wo = cohsm__v3_normalize(s->wo);
    }
    if (s->wo.z > 1.0f) s->wo.z = 1.0f;
    s->diffuse = cohsm__v3_load(m->diffuse);
    s->alpha = 0.0f;
    s->lobe_count = 0;
    specular = cohsm__specular_init(s, m);
    for (i = 0; i < s->lobe_count; i++) s->lobe_share[i] /= specular;
    diffuse = cohsm__mean3(s->diffuse);
    s->black = !(diffuse + specular > 0.0f);
    s->diffuse_share = s->black ? 1.0f : diffuse / (diffuse + specular);
    s->peak = s->diffuse_share * (1.0f / COHSM__PI);
    for (i = 0; i < s->lobe_count; i++) {
        float lobe = s->alpha > 0.0f ? 0.25f / (COHSM__PI * s->alpha * s->alpha)
                                     : (s->lobes[i].exponent + 1.0f) / (2.0f * COHSM__PI);
        s->peak += (1.0f - s->diffuse_share) * s->lobe_share[i] * lobe;
    }
}

/* GGX with Smith's height-correlated shadowing (Heitz, JCGT 3(2), 2014); 1 - nh^2 as hx^2 + hy^2, which keeps the
   digits of narrow peaks. The density is that of visible normals. */
static void cohsm__ggx(const cohsm__surface *s, cohsm__v3 wi, cohsm__response *r)
{
    cohsm__v3 h = cohsm__v3_normalize(cohsm__v3_add(s->wo, wi)), f;
    float a2 = s->alpha * s->alpha, q = h.x * h.x + h.y * h.y + a2 * h.z * h.z, d = a2 / (COHSM__PI * q * q);
    float go = sqrtf(a2 + (1.0f - a2) * s->wo.z * s->wo.z), gi = sqrtf(a2 + (1.0f - a2) * wi.z * wi.z);
    float vh = cohsm__v3_dot(s->wo, h);

    vh = vh > 0.0f ? vh < 1.0f ? vh : 1.0f : 0.0f;
    f = cohsm__schlick(s->f0, vh);
    r->specular = cohsm__v3_scale(f, 0.5f * d / (wi.z * go + s->wo.z * gi));
    r->diffuse = cohsm__v3_mul(r->diffuse, cohsm__v3_make(1.0f - f.x, 1.0f - f.y, 1.0f - f.z));
    r->specular_pdf = 0.5f * d / (s->wo.z + go);
}

static cohsm__response cohsm__respond(const cohsm__surface *s, cohsm__v3 wi)
{
    cohsm__response r;
    uint32_t i;

    memset(&r, 0, sizeof r);
    if (!(wi.z > 0.0f)) return r;
    r.diffuse = cohsm__v3_scale(s->diffuse, 1.0f / COHSM__PI);
    r.diffuse_pdf = wi.z * (1.0f / COHSM__PI);
    if (s->lobe_count && s->alpha > 0.0f) {
        cohsm__ggx(s, wi, &r);
        return r;
    }
    for (i = 0; i < s->lobe_count; i++) {
        const cohsm__cosine_lobe *lobe = &s->lobes[i];
        float c = cohsm__v3_dot(lobe->axis, wi);
        if (!(c > 0.0f)) continue;
        c = cohsm__pow(c, lobe->exponent);
        r.specular = cohsm__v3_madd(r.specular, lobe->scale, c);
        r.specular_pdf += s->lobe_share[i] * c * (lobe->exponent + 1.0f) / (2.0f * COHSM__PI);
    }
    return r;
}

static float cohsm__brdf_pdf(const cohsm__surface *s, const cohsm__response *r)
{
    return s->diffuse_share * r->diffuse_pdf + (1.0f - s->diffuse_share) * r->specular_pdf;
}

/* Visible normals by spherical caps: Dupuy and Benyoub, "Sampling visible GGX normals with spherical caps", 2023. */
static cohsm__v3 cohsm__ggx_draw(const cohsm__surface *s, float u, float v)
{
    float a = s->alpha, z, r, sn, cs, d;
    cohsm__v3 o = cohsm__v3_normalize(cohsm__v3_make(s->wo.x * a, s->wo.y * a, s->wo.z)), h;

    z = (1.0f - u) * (1.0f + o.z) - o.z;
    r = cohsm__safe_sqrt(1.0f - z * z);
    cohsm__sincos(2.0f * COHSM__PI * v, &sn, &cs);
    h = cohsm__v3_add(cohsm__v3_make(r * cs, r * sn, z), o);
    h = cohsm__v3_normalize(cohsm__v3_make(h.x * a, h.y * a, h.z));
    d = 2.0f * cohsm__v3_dot(s->wo, h);
    return cohsm__v3_normalize(cohsm__v3_sub(cohsm__v3_scale(h, d), s->wo));
}

static cohsm__v3 cohsm__lobe_draw(const cohsm__cosine_lobe *lobe, float u, float v)
{
    cohsm__v3 t, b;
    float c = cohsm__pow(1.0f - u, 1.0f / (lobe->exponent + 1.0f)), r = cohsm__safe_sqrt(1.0f - c * c), sn, cs;
    cohsm__v3_basis(lobe->axis, &t, &b);
    cohsm__sincos(2.0f * COHSM__PI * v, &sn, &cs);
    return cohsm__from_frame(t, b, lobe->axis, cohsm__v3_make(r * cs, r * sn, c));
}

/* wi in the frame; the lobe is picked by u, which is then stretched over [0, 1) again and stays stratified. */
static cohsm__v3 cohsm__brdf_draw(const cohsm__surface *s, float diffuse_share, float u, float v)
{
    uint32_t i = 0;
    if (u < diffuse_share || s->lobe_count == 0) {
        float x, y;
        cohsm__concentric(diffuse_share > 0.0f ? cohsm__clamp_unit(u / diffuse_share) : u, v, &x, &y);
        return cohsm__v3_make(x, y, cohsm__safe_sqrt(1.0f - x * x - y * y));
    }
    u = (u - diffuse_share) / (1.0f - diffuse_share);
    if (s->alpha > 0.0f) return cohsm__ggx_draw(s, cohsm__clamp_unit(u), v);
    for (; i + 1u < s->lobe_count && u >= s->lobe_share[i]; i++) u -= s->lobe_share[i];
    return cohsm__lobe_draw(&s->lobes[i], cohsm__clamp_unit(u / s->lobe_share[i]), v);
}

/* ---- >>sampling: light functions A, D, L ----------------------------------------------------------------------- */

/* ---- >>curve: an emissive mesh as small pieces along a space-filling curve ---- */

typedef struct cohsm__piece {
    double   end;                   /* share of all area up to the end of this one */
    uint64_t key;                   /* place on the curve; the lowest 31 bits number the pieces and break ties */
    float    v[9], normal[3];
} cohsm__piece;

typedef struct cohsm__curve {
    cohsm__piece *pieces;
    float        *locations;        /* four floats each */
    double        area;
    uint32_t      count, places;
} cohsm__curve;

static uint32_t cohsm__places(const cohsm_emitter_desc *d) { return d->places ? d->places : 1024u; }

/* Halved until at most area / (2 places), a triangle has fewer than 2 x 2 places x its share of the area, or is one. */
static size_t cohsm__most_pieces(const cohsm_emitter_desc *d)
{
    return cohsm__triangle_count(d->mesh) + 4u * (size_t)cohsm__places(d) + 1u;
}

static size_t cohsm__curve_size(const cohsm_emitter_desc *d)
{
    size_t bytes;
    if (!cohsm__mul_size(cohsm__most_pieces(d), sizeof(cohsm__piece), &bytes) ||
        !cohsm__add_size(bytes, 16u * (size_t)cohsm__places(d) + 16u + sizeof(cohsm__curve), &bytes))
        return 0;
    return bytes & ~(size_t)15u;
}

static cohsm__v3 cohsm__piece_corner(const float *v, uint32_t i) { return cohsm__v3_load(v + 3u * (i % 3u)); }

/* Twice the area, along the normal. */
static cohsm__v3 cohsm__cross_of(const float *v)
{
    cohsm__v3 a = cohsm__piece_corner(v, 0);
    return cohsm__v3_cross(cohsm__v3_sub(cohsm__piece_corner(v, 1), a), cohsm__v3_sub(cohsm__piece_corner(v, 2), a));
}

static double cohsm__area_of(const float *v)
{
    double area = 0.5 * (double)cohsm__v3_length(cohsm__cross_of(v));
    return area > 0.0 && area < 1e30 ? area : 0.0;
}

static void cohsm__load_triangle(const cohsm_mesh *m, size_t t, float v[9])
{
    uint32_t scratch[3], k;
    const uint32_t *c = cohsm__corners(m, t, scratch);
    for (k = 0; k < 3; k++) cohsm__v3_store(v + 3u * k, cohsm__vertex(m, c[k]));
}

/* Halves the longest edge `levels` times; the bits of number choose the halves. */
static void cohsm__cut_piece(float v[9], uint32_t levels, uint32_t number)
{
    uint32_t bit, i, edge, k;
    for (bit = 0; bit < levels; bit++) {
        float longest = -1.0f;
        for (edge = i = 0; i < 3u; i++) {
            cohsm__v3 d = cohsm__v3_sub(cohsm__piece_corner(v, i + 1u), cohsm__piece_corner(v, i));
            if (cohsm__v3_dot(d, d) > longest) {
                longest = cohsm__v3_dot(d, d);
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

/* Pieces that face the same way lie together, so that a thin plate's sides do not mix; among them a Hilbert curve. */
static uint64_t cohsm__piece_key(const cohsm__piece *p, cohsm__v3 low, float size, uint32_t number)
{
    float n[3], middle[3];
    uint32_t axis = 0, cell[3], k;
    memcpy(n, p->normal, sizeof n);
    for (k = 1; k < 3u; k++)
        if (fabsf(n[k]) > fabsf(n[axis])) axis = k;
    cohsm__v3_store(middle, cohsm__v3_add(cohsm__v3_add(cohsm__piece_corner(p->v, 0), cohsm__piece_corner(p->v, 1)),
                                          cohsm__piece_corner(p->v, 2)));
    cohsm__v3_store(middle, cohsm__v3_sub(cohsm__v3_scale(cohsm__v3_load(middle), 1.0f / 3.0f), low));
    for (k = 0; k < 3u; k++) {
        float x = middle[k] / size * 1024.0f;
        cell[k] = x > 0.0f ? x < 1023.0f ? (uint32_t)x : 1023u : 0u;
    }
    return (uint64_t)(2u * axis + (n[axis] < 0.0f)) << 61 | (uint64_t)cohsm__hilbert_index(cell, 10, 3) << 31 | number;
}

/* Heap sort by key: no memory, the same everywhere. */
static void cohsm__sort_pieces(cohsm__piece *p, size_t count)
{
    size_t built = count / 2, end = count, at, child;
    while (end > 1) {
        cohsm__piece moved;
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

static const cohsm__piece *cohsm__find_piece(const cohsm__curve *c, double x)
{
    size_t low = 0, high = c->count - 1u;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (c->pieces[middle].end > x) high = middle;
        else low = middle + 1;
    }
    return &c->pieces[low];
}

static void cohsm__curve_point(const cohsm__curve *c, const float x[3], float position[3], float normal[3], float *area)
{
    const cohsm__piece *p = cohsm__find_piece(c, (double)x[0]);
    float root = sqrtf(x[1]);
    cohsm__v3 q = cohsm__v3_scale(cohsm__piece_corner(p->v, 0), 1.0f - root);
    q = cohsm__v3_madd(q, cohsm__piece_corner(p->v, 1), root * (1.0f - x[2]));
    cohsm__v3_store(position, cohsm__v3_madd(q, cohsm__piece_corner(p->v, 2), root * x[2]));
    memcpy(normal, p->normal, sizeof p->normal);
    *area = (float)c->area;
}

/* Area of the triangles that emit, and their bounds. */
static double cohsm__survey(const cohsm_mesh *m, cohsm__v3 *low, float *size)
{
    cohsm__v3 high = cohsm__v3_make(-1e30f, -1e30f, -1e30f), d;
    size_t t, count = cohsm__triangle_count(m);
    double sum = 0.0;
    float v[9];
    uint32_t k;
    *low = cohsm__v3_make(1e30f, 1e30f, 1e30f);
    for (t = 0; t < count; t++) {
        double area;
        cohsm__load_triangle(m, t, v);
        area = cohsm__area_of(v);
        sum += area;
        for (k = 0; k < 3u && area > 0.0; k++) {
            *low = cohsm__v3_min(*low, cohsm__piece_corner(v, k));
            high = cohsm__v3_max(high, cohsm__piece_corner(v, k));
        }
    }
    d = cohsm__v3_sub(high, *low);
    *size = d.x > d.y ? d.x : d.y;
    if (d.z > *size) *size = d.z;
    return sum;
}

static void cohsm__curve_cut(cohsm__curve *c, const cohsm_mesh *m, double most, cohsm__v3 low, float size)
{
    size_t t, count = cohsm__triangle_count(m);
    for (t = 0; t < count; t++) {
        float v[9];
        double area;
        uint32_t levels = 0, i;
        cohsm__load_triangle(m, t, v);
        area = cohsm__area_of(v);
        if (!(area > 0.0)) continue;
        while (area > most) {
            area *= 0.5;
            levels++;
        }
        for (i = 0; i >> levels == 0; i++) {
            cohsm__piece *p = &c->pieces[c->count];
            memcpy(p->v, v, sizeof v);
            cohsm__cut_piece(p->v, levels, i);
            cohsm__v3_store(p->normal, cohsm__v3_normalize(cohsm__cross_of(v)));
            p->end = area;
            p->key = cohsm__piece_key(p, low, size, c->count);
            c->count++;
        }
    }
}

static cohsm_result cohsm__curve_build(const cohsm_emitter_desc *d, void *memory, cohsm__curve **out)
{
    cohsm__curve *c = (cohsm__curve *)memory;
    cohsm__v3 low;
    float size;
    double sum = 0.0;
    uint32_t i;
    c->pieces = (cohsm__piece *)(void *)((char *)memory + ((sizeof *c + 15u) & ~(size_t)15u));
    c->locations = (float *)(void *)(c->pieces + cohsm__most_pieces(d));
    c->places = cohsm__places(d);
    c->count = 0;
    c->area = cohsm__survey(d->mesh, &low, &size);
    if (!(c->area > 0.0 && size > 0.0f && cohsm__finite(size))) return COHSM_ERR_INPUT;
    cohsm__curve_cut(c, d->mesh, c->area / (2.0 * (double)c->places), low, size);
    cohsm__sort_pieces(c->pieces, c->count);
    for (i = 0; i < c->count; i++) {
        sum += c->pieces[i].end;
        c->pieces[i].end = sum / c->area;
    }
    for (i = 0; i < c->places; i++) {
        const cohsm__piece *p = cohsm__find_piece(c, ((double)i + 0.5) / (double)c->places);
        cohsm__v3 q = cohsm__v3_add(cohsm__v3_add(cohsm__piece_corner(p->v, 0), cohsm__piece_corner(p->v, 1)),
                                    cohsm__piece_corner(p->v, 2));
        q = cohsm__v3_madd(cohsm__v3_scale(q, 1.0f / 3.0f), cohsm__v3_load(p->normal), d->radius);
        cohsm__v3_store(c->locations + 4u * (size_t)i, q);
        c->locations[4u * (size_t)i + 3u] = 1.0f;
    }
    *out = c;
    return COHSM_OK;
}

struct cohsm_emitter {
    cohsm_emitter_desc desc;       /* texels: the sanitised frame at desc.time, or NULL */
    const double *edges;         /* environment: cos of the height + 1 row edges */
    cohsm__cdf2   cdf;           /* over the texels; unused without */
    const uint16_t *guide;       /* for the rows, then for the texels of each row */
    cohsm__v3     origin, n;     /* n: emission side; line: axis; sun: to it; spot: out of the lamp */
    cohsm__v3     ex, ey;        /* rectangle: dual edges; disc: frame */
    cohsm__v3     radiance, tint; /* tint . texel: its density relative to uniform coordinates; sky: per solid angle */
    float         lx, ly, area;  /* lengths of the edges */
    float         cos_cone, turn; /* turn: rotation / (2 pi) */
    int           orthogonal;
    float         location[4];   /* D of point and spot */
    const cohsm__curve *curve;   /* mesh: of shape CALLBACK from here on */
};

typedef struct cohsm__aim {      /* a light as one point sees it: what all its samples share */
    const cohsm_emitter *light;
    cohsm__v3 p, axis;           /* sphere: to the centre; line: unit, from the line to p */
    float distance;              /* sphere: to the centre; line: to its axis */
    float spread;                /* sphere: 1 - cos of the cone; line: largest sin(phi) that p sees */
    float solid_pdf;             /* above 0: sampled uniformly by solid angle */
    float solid;                 /* solid angle of what p sees: roughly, but for spheres and large rectangles */
    float x0, x1, y0, y1, z, b0, b1, k; /* rectangle: Urena et al. 2013 */
} cohsm__aim;

static int cohsm__is_delta(const cohsm_emitter *l)
{
    return l->desc.shape == COHSM_SHAPE_SUN || l->desc.shape == COHSM_SHAPE_POINT ||
           l->desc.shape == COHSM_SHAPE_SPOT;
}

static cohsm__v3 cohsm__texel(const cohsm_emitter *l, uint32_t x, uint32_t y)
{
    const float *t = l->desc.texels;
    return t ? cohsm__v3_load(t + 3u * ((size_t)y * l->desc.width + x)) : cohsm__v3_make(1.0f, 1.0f, 1.0f);
}

static uint32_t cohsm__cell(float x, uint32_t count)
{
    uint32_t i = (uint32_t)((double)x * count);
    return i < count ? i : count - 1u;
}

static cohsm__v3 cohsm__texel_at(const cohsm_emitter *l, float x, float y)
{
    return cohsm__texel(l, cohsm__cell(x, l->desc.width), cohsm__cell(y, l->desc.height));
}

/* Of what cohsm__pick returns, relative to uniform coordinates. */
static float cohsm__density(const cohsm_emitter *l, float x, float y)
{
    return l->desc.texels ? cohsm__v3_dot(cohsm__texel_at(l, x, y), l->tint) : 1.0f;
}

/* Inversion of a cdf: guide[b] is the cell where b / count of the total falls, so that the search begins a step or two
   from its end, in the same cache line. The last loops mend what rounding at the ends of a bucket may have done, and
   leave cells of weight 0. */
static uint32_t cohsm__invert(const double *sums, const uint16_t *guide, uint32_t count, float u, float *fraction)
{
    double x = (double)u * sums[count], f;
    uint32_t bucket = cohsm__cell(u, count), lo = guide[bucket], hi = bucket + 1u < count ? guide[bucket + 1u] + 1u
                                                                                          : count;
    while (hi - lo > 1u) {
        uint32_t mid = lo + (hi - lo) / 2u;
        if (sums[mid] <= x) lo = mid;
        else hi = mid;
    }
    while (lo + 1u < count && sums[lo + 1u] <= x) lo++;
    while (lo > 0 && (sums[lo] > x || !(sums[lo + 1u] > sums[lo]))) lo--;
    f = (x - sums[lo]) / (sums[lo + 1u] - sums[lo]);
    *fraction = cohsm__clamp_unit((float)f);
    return lo;
}

static void cohsm__guide_build(const double *sums, uint16_t *guide, uint32_t count)
{
    uint32_t b, i = 0;
    for (b = 0; b < count; b++) {
        double x = sums[count] * b / count;
        while (i + 1u < count && sums[i + 1u] <= x) i++;
        guide[b] = (uint16_t)i;
    }
}

/* The texel that u picks and where inside. 0 if all are black. */
static int cohsm__pick_cell(const cohsm_emitter *l, const float *u, uint32_t *x, uint32_t *y, float *fx, float *fy)
{
    uint32_t w = l->desc.width;
    if (!(cohsm__cdf2_total(&l->cdf) > 0.0)) return 0;
    *y = cohsm__invert(l->cdf.rows, l->guide, l->desc.height, u[1], fy);
    *x = cohsm__invert(l->cdf.sums + (size_t)*y * (w + 1u), l->guide + l->desc.height + (size_t)*y * w, w, u[0], fx);
    return 1;
}

/* Coordinates in proportion to the texels. */
static void cohsm__pick(const cohsm_emitter *l, const float *u, float *x, float *y)
{
    uint32_t i, j;
    *x = u[0];
    *y = u[1];
    if (!l->desc.texels || !cohsm__pick_cell(l, u, &i, &j, x, y)) return;
    *x = cohsm__clamp_unit(((float)i + *x) / (float)l->desc.width);
    *y = cohsm__clamp_unit(((float)j + *y) / (float)l->desc.height);
}

/* L at out->coords along away, times texel and the angular factors; 0 if it is black. */
static int cohsm__emit(const cohsm_emitter *l, cohsm__v3 texel, float cosine, cohsm__v3 away, cohsm_emission *out)
{
    cohsm__v3 c = cohsm__v3_mul(l->radiance, texel);
    if (l->desc.cosine_power > 0.0f) c = cohsm__v3_scale(c, cohsm__pow(cosine, l->desc.cosine_power));
    if (l->desc.emission_fn) {
        float w[3], rgb[3] = { 0.0f, 0.0f, 0.0f };
        int i;
        cohsm__v3_store(w, away);
        l->desc.emission_fn(l->desc.user, l->desc.time, out->coords, w, rgb);
        for (i = 0; i < 3; i++)
            if (!cohsm__finite(rgb[i]) || rgb[i] < 0.0f) rgb[i] = 0.0f;
        c = cohsm__v3_mul(c, cohsm__v3_load(rgb));
    }
    cohsm__v3_store(out->radiance, c);
    return cohsm__v3_finite(c) && c.x + c.y + c.z > 0.0f;
}

/* From a point of the surface to what p sees of it. The density is solid_pdf, or where that is 0 area_pdf turned into
   solid angle. n = 0: a volume. */
static int cohsm__emit_area(const cohsm__aim *a, cohsm__v3 q, cohsm__v3 n, float x, float y, float area_pdf,
                            cohsm_emission *out)
{
    const cohsm_emitter *l = a->light;
    cohsm__v3 d = cohsm__v3_sub(q, a->p), w;
    float d2 = cohsm__v3_dot(d, d), distance = sqrtf(d2), cosine;

    if (!(distance > 0.0f) || !cohsm__finite(d2)) return 0;
    w = cohsm__v3_scale(d, 1.0f / distance);
    cosine = n.x != 0.0f || n.y != 0.0f || n.z != 0.0f ? -cohsm__v3_dot(n, w) : 1.0f;
    if (!(cosine > 1e-7f)) return 0;
    if (cosine > 1.0f) cosine = 1.0f;
    out->coords[0] = cohsm__clamp_unit(x);
    out->coords[1] = cohsm__clamp_unit(y);
    out->distance = distance;
    out->pdf = a->solid_pdf > 0.0f ? a->solid_pdf : area_pdf * d2 / cosine;
    cohsm__v3_store(out->direction, w);
    return cohsm__emit(l, cohsm__texel_at(l, x, y), cosine, cohsm__v3_scale(w, -1.0f), out);
}

/* Environment: y of the texel rows by the cosines of their edges, so that solid angles are exact (T12). */
static int cohsm__environment_found(const cohsm_emitter *l, uint32_t x, uint32_t y, float u, float v, cohsm__v3 w,
                                    cohsm_emission *out)
{
    cohsm__v3 texel = cohsm__texel(l, x, y);

    u -= l->turn;
    out->coords[0] = cohsm__clamp_unit(u - floorf(u));
    out->coords[1] = cohsm__clamp_unit(v);
    out->distance = COHSM_INFINITY;
    out->pdf = cohsm__v3_dot(texel, l->tint);
    cohsm__v3_store(out->direction, w);
    return cohsm__emit(l, texel, 1.0f, w, out) && out->pdf > 0.0f;
}

static int cohsm__environment_draw(const cohsm_emitter *l, const float *u, cohsm_emission *out)
{
    float x, y, r, sn, cs, fx, fy;
    uint32_t i, j;

    if (!cohsm__pick_cell(l, u, &i, &j, &fx, &fy)) return 0;
    x = ((float)i + fx) / (float)l->desc.width;
    y = (float)(l->edges[j] + (l->edges[j + 1u] - l->edges[j]) * (double)fy);
    r = cohsm__safe_sqrt((1.0f - y) * (1.0f + y));
    cohsm__sincos(2.0f * COHSM__PI * (x - l->turn - 0.5f), &sn, &cs);
    return cohsm__environment_found(l, i, j, x, cohsm__acos(y) / COHSM__PI,
                                    cohsm__v3_make(r * cs, y, r * sn), out);
}

static int cohsm__environment_hit(const cohsm_emitter *l, cohsm__v3 w, cohsm_emission *out)
{
    float u = 0.5f + cohsm__atan2(w.z, w.x) / (2.0f * COHSM__PI) + l->turn, v = cohsm__acos(w.y) / COHSM__PI;
    u -= floorf(u);
    return cohsm__environment_found(l, cohsm__cell(u, l->desc.width), cohsm__cell(v, l->desc.height), u, v, w, out);
}

/* Rectangle by solid angle: Urena, Fajardo and King, "An area-preserving parametrization for spherical rectangles",
   EGSR 2013. In floats it needs a solid angle that is not small; smaller ones are sampled by area, no worse there. */
static void cohsm__rectangle_aim(cohsm__aim *a)
{
    const cohsm_emitter *l = a->light;
    cohsm__v3 d = cohsm__v3_sub(l->origin, a->p);
    float n0, n1, n2, n3, g0, g1, g2, g3, z2;

    a->x0 = cohsm__v3_dot(d, l->ex) * l->lx;
    a->y0 = cohsm__v3_dot(d, l->ey) * l->ly;
    a->x1 = a->x0 + l->lx;
    a->y1 = a->y0 + l->ly;
    a->z = cohsm__v3_dot(d, l->n);   /* below 0: p is on the emission side */
    z2 = a->z * a->z;
    n0 = -a->y0 / sqrtf(z2 + a->y0 * a->y0);
    n1 = a->x1 / sqrtf(z2 + a->x1 * a->x1);
    n2 = a->y1 / sqrtf(z2 + a->y1 * a->y1);
    n3 = -a->x0 / sqrtf(z2 + a->x0 * a->x0);
    g0 = cohsm__acos(-n0 * n1);
    g1 = cohsm__acos(-n1 * n2);
    g2 = cohsm__acos(-n2 * n3);
    g3 = cohsm__acos(-n3 * n0);
    a->b0 = n0;
    a->b1 = n2;
    a->k = 2.0f * COHSM__PI - g2 - g3;
    a->solid = g0 + g1 - a->k;
    if (a->solid > 0.05f && cohsm__finite(a->solid)) a->solid_pdf = 1.0f / a->solid;
}

/* Of a flat shape of this area and normal about d: right far away, at most 2 pi close by. */
static float cohsm__flat_solid(cohsm__v3 n, cohsm__v3 d, float area)
{
    float d2 = cohsm__v3_dot(d, d), cosine = fabsf(cohsm__v3_dot(n, d)) / sqrtf(d2 > 0.0f ? d2 : 1.0f);
    float near2 = area * (1.0f / (2.0f * COHSM__PI));
    return area * (cosine * d2 + near2) / ((d2 + near2) * (d2 + near2));
}

static void cohsm__rectangle_pick(const cohsm__aim *a, const float *u, float *x, float *y)
{
    float au = u[0] * a->solid + a->k, sn, cs, f, c, d, xu, yv, h0, h1, h;

    cohsm__sincos(au, &sn, &cs);
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

/* All that depends on the point alone. 0: the light does not reach p. */
static int cohsm__aim_at(cohsm__aim *a, const cohsm_emitter *l, cohsm__v3 p)
{
    cohsm__v3 d = cohsm__v3_sub(l->origin, p);
    float r = l->desc.radius, s;

    memset(a, 0, sizeof *a);
    a->light = l;
    a->p = p;
    switch (l->desc.shape) {
    case COHSM_SHAPE_RECTANGLE:
        if (!(cohsm__v3_dot(l->n, d) < 0.0f)) return 0;
        if (l->orthogonal && !l->desc.texels) cohsm__rectangle_aim(a);
        if (a->solid_pdf > 0.0f) return 1;
        d = cohsm__v3_madd(d, cohsm__v3_add(cohsm__v3_load(l->desc.u), cohsm__v3_load(l->desc.v)), 0.5f);
        a->solid = cohsm__flat_solid(l->n, d, l->area);
        return 1;
    case COHSM_SHAPE_DISC:
        a->solid = cohsm__flat_solid(l->n, d, l->area);
        return cohsm__v3_dot(l->n, d) < 0.0f;
    case COHSM_SHAPE_SPHERE:
        a->distance = cohsm__v3_length(d);
        if (!(a->distance > r)) return 0;
        a->axis = cohsm__v3_scale(d, 1.0f / a->distance);
        s = (r / a->distance) * (r / a->distance);
        a->spread = s / (1.0f + sqrtf(1.0f - s));
        a->solid = 2.0f * COHSM__PI * a->spread;
        if (!l->desc.texels && a->spread > 0.0f) a->solid_pdf = 1.0f / a->solid;
        return 1;
    case COHSM_SHAPE_LINE:
        s = cohsm__v3_dot(d, l->n);
        d = cohsm__v3_sub(cohsm__v3_scale(l->n, s), d);
        a->distance = cohsm__v3_length(d);
        if (!(a->distance > r)) return 0;
        a->axis = cohsm__v3_scale(d, 1.0f / a->distance);
        a->spread = cohsm__safe_sqrt(1.0f - (r / a->distance) * (r / a->distance));
        d = cohsm__v3_make(a->distance, s, s + l->lx);   /* the line seen edge to edge: sines of its ends */
        a->solid = 2.0f * r / d.x * (d.z / sqrtf(d.x * d.x + d.z * d.z) - d.y / sqrtf(d.x * d.x + d.y * d.y));
        return 1;
    default:
        return 1;
    }
}

/* A of what is flat or round; a line is its axis. */
static cohsm__v3 cohsm__shape_point(const cohsm_emitter *l, float x, float y)
{
    float dx, dy, sn, cs, r = l->desc.radius;
    cohsm__v3 a, b;

    switch (l->desc.shape) {
    case COHSM_SHAPE_LINE:
        return cohsm__v3_madd(l->origin, l->n, x * l->lx);
    case COHSM_SHAPE_RECTANGLE:
        a = cohsm__v3_scale(cohsm__v3_load(l->desc.u), x);
        b = cohsm__v3_scale(cohsm__v3_load(l->desc.v), y);
        return cohsm__v3_add(l->origin, cohsm__v3_add(a, b));
    case COHSM_SHAPE_DISC:
        cohsm__concentric(x, y, &dx, &dy);
        a = cohsm__v3_add(cohsm__v3_scale(l->ex, dx), cohsm__v3_scale(l->ey, dy));
        return cohsm__v3_madd(l->origin, a, r);
    case COHSM_SHAPE_SPHERE:
        dy = 1.0f - 2.0f * y;
        dx = cohsm__safe_sqrt(1.0f - dy * dy);
        cohsm__sincos(2.0f * COHSM__PI * (x - 0.5f), &sn, &cs);
        return cohsm__v3_madd(l->origin, cohsm__v3_make(dx * cs, dy, dx * sn), r);
    default:
        return l->origin;
    }
}

/* The cylinder by y, spread evenly over the breadth that p sees: the lamp's own cosine drops out. */
static int cohsm__line_at(const cohsm__aim *a, float x, float sine, cohsm_emission *out)
{
    const cohsm_emitter *l = a->light;
    float cosine = cohsm__safe_sqrt(1.0f - sine * sine);
    cohsm__v3 n = cohsm__v3_scale(a->axis, cosine), q;

    n = cohsm__v3_madd(n, cohsm__v3_cross(l->n, a->axis), sine);
    q = cohsm__v3_madd(cohsm__shape_point(l, x, 0.0f), n, l->desc.radius);
    return cohsm__emit_area(a, q, n, x, 0.0f, cohsm__density(l, x, 0.0f) * cosine /
                                                  (2.0f * a->spread * l->desc.radius * l->lx), out);
}

static int cohsm__sphere_at(const cohsm__aim *a, cohsm__v3 n, cohsm_emission *out)
{
    const cohsm_emitter *l = a->light;
    float x = 0.5f + cohsm__atan2(n.z, n.x) / (2.0f * COHSM__PI), y = 0.5f * (1.0f - n.y);
    x = cohsm__clamp_unit(x);
    y = cohsm__clamp_unit(y);
    return cohsm__emit_area(a, cohsm__v3_madd(l->origin, n, l->desc.radius), n, x, y,
                            cohsm__density(l, x, y) / l->area, out);
}

static int cohsm__sphere_draw(const cohsm__aim *a, const float *u, cohsm_emission *out)
{
    const cohsm_emitter *l = a->light;
    float r = l->desc.radius, x, y, sn, cs, c, s2, along, reach;
    cohsm__v3 t, b, n;

    if (!(a->solid_pdf > 0.0f)) {
        cohsm__pick(l, u, &x, &y);
        n = cohsm__v3_sub(cohsm__shape_point(l, x, y), l->origin);
        return cohsm__sphere_at(a, cohsm__v3_normalize(n), out);
    }
    /* Cone about the axis; the normal where the ray meets the sphere follows from the law of sines. */
    c = u[0] * a->spread;
    s2 = c * (2.0f - c);
    c = 1.0f - c;
    reach = cohsm__safe_sqrt(r * r - a->distance * a->distance * s2);
    along = a->distance * s2 + c * reach;       /* from the centre towards p */
    x = cohsm__safe_sqrt(s2) * (a->distance * c - reach) / r;
    cohsm__sincos(2.0f * COHSM__PI * u[1], &sn, &cs);
    cohsm__v3_basis(a->axis, &t, &b);
    n = cohsm__from_frame(t, b, a->axis, cohsm__v3_make(x * cs, x * sn, -along / r));
    return cohsm__sphere_at(a, cohsm__v3_normalize(n), out);
}

static int cohsm__delta_draw(const cohsm__aim *a, cohsm_emission *out)
{
    const cohsm_emitter *l = a->light;
    cohsm__v3 d = cohsm__v3_sub(l->origin, a->p), w = l->n;
    float distance = cohsm__v3_length(d), scale = 1.0f;

    out->pdf = 1.0f;
    out->distance = COHSM_INFINITY;
    if (l->desc.shape != COHSM_SHAPE_SUN) {
        if (!(distance > 0.0f) || !cohsm__finite(distance)) return 0;
        w = cohsm__v3_scale(d, 1.0f / distance);
        if (l->desc.shape == COHSM_SHAPE_SPOT && -cohsm__v3_dot(w, l->n) < l->cos_cone) return 0;
        scale = 1.0f / (distance * distance);
        out->distance = distance;
    }
    cohsm__v3_store(out->direction, w);
    return cohsm__emit(l, cohsm__v3_make(scale, scale, scale), 1.0f, cohsm__v3_scale(w, -1.0f), out);
}

static int cohsm__callback_draw(const cohsm__aim *a, const float *u, cohsm_emission *out)
{
    const cohsm_emitter *l = a->light;
    float q[3] = { 0.0f, 0.0f, 0.0f }, n[3] = { 0.0f, 0.0f, 0.0f }, area = 0.0f, x, y;

    cohsm__pick(l, u, &x, &y);
    out->coords[0] = x;
    out->coords[1] = y;
    out->coords[2] = u[2];
    if (l->curve) cohsm__curve_point(l->curve, out->coords, q, n, &area);
    else l->desc.shape_fn(l->desc.user, l->desc.time, out->coords, q, n, &area);
    if (!cohsm__v3_finite(cohsm__v3_load(q)) || !cohsm__v3_finite(cohsm__v3_load(n)) || !cohsm__finite(area) ||
        !(area > 0.0f))
        return 0;
    return cohsm__emit_area(a, cohsm__v3_load(q), cohsm__v3_normalize(cohsm__v3_load(n)), x, y,
                            cohsm__density(l, x, y) / area, out);
}

static int cohsm__emitter_draw(const cohsm__aim *a, const float *u, cohsm_emission *out)
{
    const cohsm_emitter *l = a->light;
    float x, y;

    memset(out, 0, sizeof *out);
    switch (l->desc.shape) {
    case COHSM_SHAPE_RECTANGLE:
    case COHSM_SHAPE_DISC:
        if (a->solid_pdf > 0.0f) cohsm__rectangle_pick(a, u, &x, &y);
        else cohsm__pick(l, u, &x, &y);
        return cohsm__emit_area(a, cohsm__shape_point(l, x, y), l->n, x, y, cohsm__density(l, x, y) / l->area, out);
    case COHSM_SHAPE_SPHERE:
        return cohsm__sphere_draw(a, u, out);
    case COHSM_SHAPE_LINE:
        cohsm__pick(l, u, &x, &y);
        return cohsm__line_at(a, x, (2.0f * u[1] - 1.0f) * a->spread, out);
    case COHSM_SHAPE_CALLBACK:
        return cohsm__callback_draw(a, u, out);
    case COHSM_SHAPE_SUN:
    case COHSM_SHAPE_POINT:
    case COHSM_SHAPE_SPOT:
        return cohsm__delta_draw(a, out);
    default:
        return cohsm__environment_draw(l, u, out);
    }
}

/* Rectangle and disc: the plane, then the edges. */
static int cohsm__plane_hit(const cohsm__aim *a, cohsm__v3 w, cohsm_emission *out)
{
    const cohsm_emitter *l = a->light;
    cohsm__v3 d = cohsm__v3_sub(a->p, l->origin), q;
    float slope = -cohsm__v3_dot(l->n, w), height = cohsm__v3_dot(l->n, d), x, y;

    if (!(slope > 1e-7f) || !(height > 0.0f)) return 0;
    d = cohsm__v3_madd(d, w, height / slope);
    q = cohsm__v3_add(l->origin, d);
    x = cohsm__v3_dot(d, l->ex);
    y = cohsm__v3_dot(d, l->ey);
    if (l->desc.shape == COHSM_SHAPE_DISC) {
        x /= l->desc.radius;
        y /= l->desc.radius;
        if (!(x * x + y * y < 1.0f)) return 0;
        cohsm__disc_square(x, y, &x, &y);
    } else if (!(x >= 0.0f && x < 1.0f && y >= 0.0f && y < 1.0f)) {
        return 0;
    }
    return cohsm__emit_area(a, q, l->n, x, y, cohsm__density(l, x, y) / l->area, out);
}

/* Sphere and line: the nearer root, measured from the foot of the perpendicular, which keeps its digits. */
static int cohsm__round_hit(const cohsm__aim *a, cohsm__v3 w, cohsm_emission *out)
{
    const cohsm_emitter *l = a->light;
    cohsm__v3 d = cohsm__v3_sub(l->origin, a->p), v = w, n;
    float r = l->desc.radius, along, s, x, len2;

    if (l->desc.shape == COHSM_SHAPE_LINE) {     /* what is across the axis: a circle */
        d = cohsm__v3_scale(a->axis, -a->distance);
        v = cohsm__v3_madd(w, l->n, -cohsm__v3_dot(w, l->n));
    }
    len2 = cohsm__v3_dot(v, v);
    if (!(len2 > 1e-14f)) return 0;
    along = cohsm__v3_dot(d, v) / len2;
    n = cohsm__v3_sub(cohsm__v3_scale(v, along), d);
    s = r * r - cohsm__v3_dot(n, n);
    if (!(along > 0.0f) || !(s > 0.0f)) return 0;
    s = sqrtf(s / len2);
    n = cohsm__v3_scale(cohsm__v3_madd(n, v, -s), 1.0f / r);
    if (l->desc.shape == COHSM_SHAPE_SPHERE) return cohsm__sphere_at(a, cohsm__v3_normalize(n), out);
    x = cohsm__v3_dot(cohsm__v3_madd(cohsm__v3_sub(a->p, l->origin), w, along - s), l->n) / l->lx;
    if (!(x >= 0.0f && x < 1.0f)) return 0;
    return cohsm__line_at(a, x, cohsm__v3_dot(n, cohsm__v3_cross(l->n, a->axis)), out);
}

static int cohsm__aim_hit(const cohsm__aim *a, cohsm__v3 w, cohsm_emission *out)
{
    memset(out, 0, sizeof *out);
    switch (a->light->desc.shape) {
    case COHSM_SHAPE_RECTANGLE:
    case COHSM_SHAPE_DISC:
        return cohsm__plane_hit(a, w, out);
    case COHSM_SHAPE_SPHERE:
    case COHSM_SHAPE_LINE:
        return cohsm__round_hit(a, w, out);
    case COHSM_SHAPE_DEFAULT:
    case COHSM_SHAPE_ENVIRONMENT:
        return cohsm__environment_hit(a->light, w, out);
    default:
        return 0;
    }
}

static int cohsm__emitter_valid(const cohsm_emitter_desc *d)
{
    const float big = 1e18f;
    cohsm__v3 n = cohsm__v3_cross(cohsm__v3_load(d->u), cohsm__v3_load(d->v));

    if (!cohsm__in3(d->radiance, 0.0f, 3e38f) || !cohsm__in(d->time, -1e9f, 1e9f) ||
        !cohsm__in(d->cosine_power, 0.0f, 1e5f) || !cohsm__in(d->rotation, -1000.0f, 1000.0f) ||
        !cohsm__in(d->frames_per_second, 0.0f, 1e6f))
        return 0;
    if (d->texels ? !d->width || !d->height || d->width > 65536u || d->height > 65536u || d->frames > 1u << 24
                  : d->width || d->height || d->frames > 1)
        return 0;
    if (d->shape == COHSM_SHAPE_DEFAULT || d->shape == COHSM_SHAPE_ENVIRONMENT) return d->cosine_power == 0.0f;
    if (d->shape == COHSM_SHAPE_CALLBACK) return d->shape_fn != NULL;
    if (d->shape == COHSM_SHAPE_MESH)
        return cohsm__check_mesh(d->mesh) == COHSM_OK && d->places <= 1u << 24 && !d->texels &&
               cohsm__in(d->radius, 0.0f, big);
    if (!cohsm__in3(d->position, -big, big)) return 0;
    switch (d->shape) {
    case COHSM_SHAPE_SUN:
        return !d->texels && !d->emission_fn && cohsm__is_unit(d->direction);
    case COHSM_SHAPE_POINT:
        return !d->texels && !d->emission_fn;
    case COHSM_SHAPE_SPOT:
        return !d->texels && !d->emission_fn && cohsm__is_unit(d->direction) &&
               cohsm__in(d->cone_angle, 1e-6f, COHSM__PI);
    case COHSM_SHAPE_LINE:
        return cohsm__in3(d->u, -big, big) && cohsm__v3_length(cohsm__v3_load(d->u)) > 0.0f &&
               cohsm__in(d->radius, 1e-18f, big) && (!d->texels || d->height == 1u);
    case COHSM_SHAPE_RECTANGLE:
        return cohsm__in3(d->u, -big, big) && cohsm__in3(d->v, -big, big) && cohsm__v3_finite(n) &&
               cohsm__v3_length(n) > 0.0f && cohsm__finite(cohsm__v3_length(n));
    case COHSM_SHAPE_DISC:
        return cohsm__is_unit(d->direction) && cohsm__in(d->radius, 1e-18f, big);
    case COHSM_SHAPE_SPHERE:
        return cohsm__in(d->radius, 1e-18f, big);
    default:
        return 0;
    }
}

static int cohsm__is_environment(const cohsm_emitter_desc *d)
{
    return d->shape == COHSM_SHAPE_DEFAULT || d->shape == COHSM_SHAPE_ENVIRONMENT;
}

#define COHSM__EMITTER_HEAD ((sizeof(struct cohsm_emitter) + 15u) & ~(size_t)15u)

COHSM_DEF size_t cohsm_emitter_triangles(const cohsm_emitter *emitter, float *corners)
{
    uint32_t i;
    if (!emitter || !emitter->curve) return 0;
    for (i = 0; corners && i < emitter->curve->count; i++)
        memcpy(corners + 9u * (size_t)i, emitter->curve->pieces[i].v, 9 * sizeof *corners);
    return emitter->curve->count;
}

COHSM_DEF size_t cohsm_emitter_size(const cohsm_emitter_desc *desc)
{
    size_t doubles, edges, bytes;
    uint32_t w, h;

    if (!desc || !cohsm__emitter_valid(desc)) return 0;
    if (desc->shape == COHSM_SHAPE_MESH) {
        bytes = cohsm__curve_size(desc);
        return bytes && cohsm__add_size(bytes, COHSM__EMITTER_HEAD, &bytes) ? bytes : 0;
    }
    if (!desc->texels && !cohsm__is_environment(desc)) return COHSM__EMITTER_HEAD;
    w = desc->texels ? desc->width : 1u;
    h = desc->texels ? desc->height : 1u;
    edges = cohsm__is_environment(desc) ? h + 1u : 0u;
    doubles = cohsm__cdf2_doubles(w, h);
    /* texels, one row of weights and the guides; then the sums. Sides of 65536 at most: 14 h + 4 never overflows */
    if (!doubles || !cohsm__mul_size(w, (size_t)h * 14u + 4u, &bytes) ||
        !cohsm__add_size(bytes, COHSM__EMITTER_HEAD + 2u * h, &bytes) || !cohsm__add_size(doubles, edges, &doubles) ||
        !cohsm__mul_size(doubles, sizeof(double), &doubles) || !cohsm__add_size(bytes, doubles, &bytes))
        return 0;
    return bytes;
}

/* cos(pi y / h) to the last digits of a double: sines up to pi / 4, so that rows at the poles keep theirs (T12). */
static double cohsm__row_edge(uint32_t y, uint32_t h)
{
    uint32_t m = y < h - y ? y : h - y;
    double x = 1.5707963267948966 * m / h, z = x * x, s;
    s = 1.0 - z / 110.0 * (1.0 - z / 156.0 * (1.0 - z / 210.0));
    s = x * (1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0 * s))));
    s = 1.0 - 2.0 * s * s;
    return m == y ? s : -s;
}

/* The frame at desc.time, linear between its neighbours, with bad channels 0. Returns the number of bad texels. */
static uint64_t cohsm__emitter_frame(const cohsm_emitter_desc *d, float *texels)
{
    uint32_t frames = d->frames ? d->frames : 1u, f0, f1;
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
            if (!cohsm__finite(a) || a < 0.0f) broken = 1, a = 0.0f;
            if (!cohsm__finite(b) || b < 0.0f) broken = 1, b = 0.0f;
            texels[i * 3u + (size_t)c] = a * (1.0f - blend) + b * blend;
        }
        bad += (uint64_t)broken;
    }
    return bad;
}

/* cdf over the texels in proportion to what they send out, all three channels (T18). */
static void cohsm__emitter_cdf(cohsm_emitter *l, double *memory, float *row, uint16_t *guide)
{
    uint32_t w = l->desc.width, h = l->desc.height, x, y;
    double *rows = memory, *sums = memory + h + 1u, total = 0.0;
    float top = l->radiance.x > l->radiance.y ? l->radiance.x : l->radiance.y, norm;
    cohsm__v3 tint = cohsm__v3_make(1.0f, 1.0f, 1.0f);

    top = top > l->radiance.z ? top : l->radiance.z;
    if (top > 0.0f) tint = cohsm__v3_make(l->radiance.x / top, l->radiance.y / top, l->radiance.z / top);
    tint = cohsm__v3_scale(tint, 1.0f / 3.0f);
    for (y = 0; y < h; y++) {
        cohsm__cdf line;
        double *at = sums + (size_t)y * (w + 1u);
        for (x = 0; x < w; x++) row[x] = cohsm__v3_dot(cohsm__texel(l, x, y), tint);
        (void)cohsm__cdf_build(&line, at, row, w, l->edges ? l->edges[y] - l->edges[y + 1u] : 1.0);
        cohsm__guide_build(at, guide + h + (size_t)y * w, w);
        rows[y] = total;
        total += cohsm__cdf_total(&line);
    }
    rows[h] = total;
    cohsm__guide_build(rows, guide, h);
    l->guide = guide;
    norm = (float)(total > 0.0 ? (l->edges ? w / (6.283185307179586 * total) : (double)w * h / total) : 0.0);
    l->tint = cohsm__v3_scale(tint, norm);
    l->cdf.rows = rows;
    l->cdf.sums = sums;
    l->cdf.width = w;
    l->cdf.height = h;
}

static void cohsm__emitter_geometry(cohsm_emitter *l)
{
    const cohsm_emitter_desc *d = &l->desc;
    cohsm__v3 u = cohsm__v3_load(d->u), v = cohsm__v3_load(d->v), n;
    float area2;

    l->origin = cohsm__v3_load(d->position);
    l->radiance = cohsm__v3_load(d->radiance);
    l->n = cohsm__v3_normalize(cohsm__v3_load(d->direction));
    l->cos_cone = d->shape == COHSM_SHAPE_SPOT ? cohsm__cos(0.5f * d->cone_angle) : 0.0f;
    l->turn = d->rotation / (2.0f * COHSM__PI);
    l->area = 1.0f;
    memcpy(l->location, d->position, sizeof d->position);
    l->location[3] = 1.0f;
    if (d->shape == COHSM_SHAPE_LINE) {
        l->n = cohsm__v3_normalize(u);
        l->lx = cohsm__v3_length(u);
    } else if (d->shape == COHSM_SHAPE_DISC) {
        cohsm__v3_basis(l->n, &l->ex, &l->ey);
        l->area = COHSM__PI * d->radius * d->radius;
    } else if (d->shape == COHSM_SHAPE_SPHERE) {
        l->area = 4.0f * COHSM__PI * d->radius * d->radius;
    } else if (d->shape == COHSM_SHAPE_RECTANGLE) {
        n = cohsm__v3_cross(u, v);
        l->area = cohsm__v3_length(n);
        l->n = cohsm__v3_normalize(n);
        l->lx = cohsm__v3_length(u);
        l->ly = cohsm__v3_length(v);
        area2 = 1.0f / l->area;
        l->ex = cohsm__v3_scale(cohsm__v3_cross(v, l->n), area2);
        l->ey = cohsm__v3_scale(cohsm__v3_cross(l->n, u), area2);
        l->orthogonal = fabsf(cohsm__v3_dot(u, v)) <= 1e-5f * l->area;
    }
}

COHSM_DEF cohsm_result cohsm_emitter_build(const cohsm_emitter_desc *desc, void *memory, size_t memory_size,
                                         cohsm_emitter **out, uint64_t *bad_texels)
{
    size_t size = cohsm_emitter_size(desc);
    cohsm_emitter *l = (cohsm_emitter *)memory;
    uint64_t bad = 0;

    if (!desc || !memory || !out) return COHSM_ERR_ARGUMENT;
    if (!size) return COHSM_ERR_DESC;
    if (memory_size < size || ((uintptr_t)memory & 7u)) return COHSM_ERR_MEMORY;
    memset(l, 0, sizeof *l);
    l->desc = *desc;
    if (desc->shape == COHSM_SHAPE_DEFAULT) l->desc.shape = COHSM_SHAPE_ENVIRONMENT;
    l->desc.texels = NULL;
    cohsm__emitter_geometry(l);
    if (desc->shape == COHSM_SHAPE_MESH) {
        cohsm__curve *curve;
        cohsm_result result = cohsm__curve_build(desc, (char *)memory + COHSM__EMITTER_HEAD, &curve);
        if (result != COHSM_OK) return result;
        l->curve = curve;
        l->desc.shape = COHSM_SHAPE_CALLBACK;
    }
    if (desc->texels || cohsm__is_environment(desc)) {
        static const float white[3] = { 1.0f, 1.0f, 1.0f };
        double *sums = (double *)(void *)((char *)memory + COHSM__EMITTER_HEAD);
        float *texels, *row;
        uint32_t y;

        if (!desc->texels) {
            l->desc.width = l->desc.height = 1;
            l->desc.texels = white;
        } else {
            l->desc.texels = desc->texels;
        }
        if (cohsm__is_environment(desc)) {
            for (y = 0; y <= l->desc.height; y++) sums[y] = cohsm__row_edge(y, l->desc.height);
            l->edges = sums;
            sums += l->desc.height + 1u;
        }
        texels = (float *)(void *)(sums + cohsm__cdf2_doubles(l->desc.width, l->desc.height));
        bad = cohsm__emitter_frame(&l->desc, texels);
        l->desc.texels = texels;
        row = texels + (size_t)l->desc.width * l->desc.height * 3u;
        cohsm__emitter_cdf(l, sums, row, (uint16_t *)(void *)(row + l->desc.width));
    }
    if (bad_texels) *bad_texels = bad;
    *out = l;
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_emitter_domain(const cohsm_emitter *emitter, cohsm_domain *out)
{
    static const cohsm_domain_kind kinds[10] = {
        COHSM_DOMAIN_LATLONG, COHSM_DOMAIN_LATLONG, COHSM_DOMAIN_LATLONG, COHSM_DOMAIN_LIST, COHSM_DOMAIN_LIST,
        COHSM_DOMAIN_LINE, COHSM_DOMAIN_RECTANGLE, COHSM_DOMAIN_DISC, COHSM_DOMAIN_SPHERE, COHSM_DOMAIN_TABLE
    };
    const cohsm_emitter_desc *d;

    if (!emitter || !out) return COHSM_ERR_ARGUMENT;
    d = &emitter->desc;
    if (d->shape == COHSM_SHAPE_CALLBACK && !emitter->curve) return COHSM_ERR_DOMAIN;
    memset(out, 0, sizeof *out);
    out->kind = kinds[d->shape];
    if (emitter->curve) {
        out->side[0] = emitter->curve->places;
        out->side[1] = out->side[2] = 1;
        out->locations = emitter->curve->locations;
        out->location_count = emitter->curve->places;
        return COHSM_OK;
    }
    memcpy(out->origin, d->position, sizeof out->origin);
    memcpy(out->u, d->u, sizeof out->u);
    memcpy(out->v, d->v, sizeof out->v);
    if (d->shape == COHSM_SHAPE_DISC) {
        cohsm__v3_store(out->u, cohsm__v3_scale(emitter->ex, d->radius));
        cohsm__v3_store(out->v, cohsm__v3_scale(emitter->ey, d->radius));
    } else if (d->shape == COHSM_SHAPE_SPHERE) {
        cohsm__v3_store(out->u, cohsm__v3_make(d->radius, 0.0f, 0.0f));
    } else if (out->kind == COHSM_DOMAIN_LIST) {
        out->locations = emitter->location;
        out->location_count = 1;
    }
    return COHSM_OK;
}

COHSM_DEF int cohsm_emitter_sample(const cohsm_emitter *light, const float p[3], const float u[3], cohsm_emission *out)
{
    cohsm__aim aim;
    cohsm_emission e;

    if (!light || !p || !u || !out || !cohsm__v3_finite(cohsm__v3_load(p)) || !cohsm__in3(u, 0.0f, 1.0f))
        return 0;
    if (!cohsm__aim_at(&aim, light, cohsm__v3_load(p)) || !cohsm__emitter_draw(&aim, u, &e)) return 0;
    *out = e;
    return 1;
}

COHSM_DEF int cohsm_emitter_hit(const cohsm_emitter *light, const float p[3], const float direction[3],
                              cohsm_emission *out)
{
    cohsm__aim aim;
    cohsm_emission e;

    if (!light || !p || !direction || !out || !cohsm__v3_finite(cohsm__v3_load(p)) || !cohsm__is_unit(direction))
        return 0;
    if (!cohsm__aim_at(&aim, light, cohsm__v3_load(p)) ||
        !cohsm__aim_hit(&aim, cohsm__v3_normalize(cohsm__v3_load(direction)), &e))
        return 0;
    *out = e;
    return 1;
}

/* ---- >>sampling: the estimator --------------------------------------------------------------------------------- */

COHSM_DEF size_t cohsm_patterns_size(uint32_t length)
{
    if (length == 0 || length > 65536u) return 0;
    return (size_t)COHSM_PATTERN_COUNT * length * 2u * sizeof(float);
}

/* Hammersley points with one axis jittered inside the columns, the other Owen-scrambled. In integers of 24 bits, so
   that no rounding takes a point across the edge of its column. */
COHSM_DEF cohsm_result cohsm_patterns_build(uint32_t length, uint32_t seed, float *patterns, size_t size)
{
    size_t need = cohsm_patterns_size(length);
    uint32_t j, k;

    if (!patterns) return COHSM_ERR_ARGUMENT;
    if (!need) return COHSM_ERR_DESC;
    if (size < need) return COHSM_ERR_MEMORY;
    for (j = 0; j < COHSM_PATTERN_COUNT; j++) {
        uint32_t scramble = cohsm__hash_combine(seed, j);
        for (k = 0; k < length; k++, patterns += 2) {
            uint32_t low = (uint32_t)((((uint64_t)k << 24) + length - 1u) / length);
            uint32_t high = (uint32_t)((((uint64_t)(k + 1u) << 24) + length - 1u) / length);
            uint32_t at = low + (uint32_t)(cohsm__random(seed, ~j, k) * (float)(high - low));
            patterns[0] = (float)(at < high ? at : high - 1u) * (1.0f / 16777216.0f);
            patterns[1] = cohsm__to_unit(cohsm__owen(cohsm__reverse_bits(k), scramble));
        }
    }
    return COHSM_OK;
}

/* Random numbers of sample k. 159 is odd and close to 256 / golden ratio: the patterns of successive frames are far
   apart and all 256 get their turn; then they come again with a toroidal shift. */
static void cohsm__numbers(const cohsm_sample_desc *d, uint32_t pixel, uint32_t k, int third, float *u)
{
    uint32_t key = cohsm__hash_combine(d->seed, pixel), index = d->frame * d->samples + k;

    if (d->patterns) {
        const float *at = d->patterns + ((size_t)((key + d->frame * 159u) & 255u) * d->samples + k) * 2u;
        u[0] = at[0];
        u[1] = at[1];
        if (d->frame > 255u) {
            u[0] += cohsm__random(key, d->frame >> 8, 0u);
            u[1] += cohsm__random(key, d->frame >> 8, 1u);
            u[0] = cohsm__clamp_unit(u[0] - floorf(u[0]));
            u[1] = cohsm__clamp_unit(u[1] - floorf(u[1]));
        }
    } else {
        cohsm__sobol2(index, key, &u[0], &u[1]);
    }
    u[2] = third ? cohsm__random(key, 0x9e3779b9u, index) : 0.0f;
}

typedef struct cohsm__estimator { /* one point and one light */
    const cohsm_sample_desc *desc;
    cohsm__surface surface;
    cohsm__aim     aim;
    int            reachable;    /* by the light */
    int            split;        /* paper: the two parts of the BRDF are two integrals */
    float          light_share;  /* of the samples, by roulette */
} cohsm__estimator;

/* Few BRDF samples where the light is smaller than the lobe, few light samples where the lobe is smaller: with
   q = (solid angle) (peak density) the BRDF's share q^3 / (8 + q^3) had 0.29 of the noise of one half over 54 pairs of
   light and material (64 samples, geometric mean), 0.68 of it under shadows; q / (1 + q) 0.52 and 0.76. Whole samples,
   so that stratified numbers are split without a remainder. */
static void cohsm__estimator_init(cohsm__estimator *e, const cohsm_sample_desc *desc, const cohsm_emitter *light)
{
    int unseen = cohsm__is_delta(light) || light->desc.shape == COHSM_SHAPE_CALLBACK;
    int distant = light->desc.shape == COHSM_SHAPE_ENVIRONMENT;
    float q;

    e->desc = desc;
    e->split = distant && desc->sampling == COHSM_SAMPLING_PAPER;
    e->light_share = 1.0f;
    if (unseen || desc->sampling == COHSM_SAMPLING_LIGHT || !e->reachable) return;
    if (desc->sampling == COHSM_SAMPLING_BRDF) e->light_share = 0.0f;
    else if (desc->sampling == COHSM_SAMPLING_PAPER) e->light_share = distant ? e->surface.diffuse_share : 1.0f;
    else if (distant) e->light_share = 0.5f;
    else {
        q = e->aim.solid * e->surface.peak;
        e->light_share = 8.0f / (8.0f + q * q * q);
        e->light_share = floorf(e->light_share * (float)desc->samples + 0.5f) / (float)desc->samples;
    }
}

/* One sample: roulette between light and BRDF, both with the first number, stretched again. The densities of both
   techniques are summed in proportion: the one-sample form of the balance heuristic. Returns the weight times S. */
static cohsm__v3 cohsm__estimate(const cohsm__estimator *e, const float *numbers, cohsm_emission *found)
{
    const cohsm__v3 zero = cohsm__v3_make(0.0f, 0.0f, 0.0f);
    const cohsm__surface *s = &e->surface;
    float u[3], c = e->light_share, pdf;
    int by_light = numbers[0] < c, hit;
    cohsm__v3 wi, f;
    cohsm__response r;

    u[0] = cohsm__clamp_unit(by_light ? numbers[0] / c : (numbers[0] - c) / (1.0f - c));
    u[1] = numbers[1];
    u[2] = numbers[2];
    if (by_light) {
        hit = cohsm__emitter_draw(&e->aim, u, found);
    } else {
        wi = cohsm__brdf_draw(s, e->split ? 0.0f : s->diffuse_share, u[0], u[1]);
        hit = wi.z > 0.0f && cohsm__aim_hit(&e->aim, cohsm__from_frame(s->t, s->b, s->n, wi), found);
    }
    if (!hit) {
        memset(found, 0, sizeof *found);
        return zero;
    }
    wi = cohsm__to_frame(s, cohsm__v3_load(found->direction));
    r = cohsm__respond(s, wi);
    if (e->split) {
        f = by_light ? r.diffuse : r.specular;
        pdf = by_light ? c * found->pdf : (1.0f - c) * r.specular_pdf;
    } else {
        f = cohsm__v3_add(r.diffuse, r.specular);
        pdf = c * found->pdf + (1.0f - c) * cohsm__brdf_pdf(s, &r);
    }
    if (!(wi.z > 0.0f) || !(pdf > 0.0f)) return zero;
    f = cohsm__v3_scale(cohsm__v3_mul(f, cohsm__v3_load(found->radiance)), wi.z / pdf);
    return cohsm__v3_finite(f) ? f : zero;
}

#define COHSM__SAMPLE_BLOCK 32u

/* Large maps do not fit the cache: asks for what the light samples of a block will read, one dependency at a time. */
static void cohsm__environment_warm(const cohsm__estimator *e, float (*u)[3], uint32_t count)
{
    const cohsm_emitter *l = e->aim.light;
    uint32_t k, w = l->desc.width, h = l->desc.height;
    size_t at[COHSM__SAMPLE_BLOCK];
    float unused;

    if (l->desc.shape != COHSM_SHAPE_ENVIRONMENT || !(cohsm__cdf2_total(&l->cdf) > 0.0)) return;
    for (k = 0; k < count; k++) {
        uint32_t y = cohsm__invert(l->cdf.rows, l->guide, h, u[k][1], &unused);
        at[k] = (size_t)y * w;
        if (!(u[k][0] < e->light_share)) continue;
        COHSM__PREFETCH(l->guide + h + at[k] + cohsm__cell(u[k][0] / e->light_share, w));
    }
    for (k = 0; k < count; k++) {
        uint32_t x;
        if (!(u[k][0] < e->light_share)) continue;
        x = l->guide[h + at[k] + cohsm__cell(u[k][0] / e->light_share, w)];
        COHSM__PREFETCH(l->cdf.sums + at[k] + at[k] / w + x);
        COHSM__PREFETCH(l->desc.texels + (at[k] + x) * 3u);
    }
}

static const float *cohsm__row(const float *base, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)base + (stride ? stride : 12u) * i);
}

static const cohsm_material *cohsm__material_at(const cohsm_points *p, size_t i)
{
    return (const cohsm_material *)(const void *)((const char *)p->materials + p->material_stride * i);
}

static cohsm_result cohsm__points_check(const cohsm_points *p)
{
    size_t i;

    if (p->count == 0) return COHSM_OK;
    if (!p->positions || !p->normals || !p->materials || !cohsm__stride_valid(p->position_stride, 12) ||
        !cohsm__stride_valid(p->normal_stride, 12) || !cohsm__stride_valid(p->view_stride, 12) ||
        !cohsm__stride_valid(p->tangent_stride, 12) || p->material_stride % sizeof(void *) ||
        (p->material_stride && p->material_stride < sizeof(cohsm_material)))
        return COHSM_ERR_ARGUMENT;
    for (i = 0; i < p->count; i++) {
        if (!cohsm__v3_finite(cohsm__v3_load(cohsm__row(p->positions, p->position_stride, i))) ||
            !cohsm__is_unit(cohsm__row(p->normals, p->normal_stride, i)) ||
            (p->views && !cohsm__is_unit(cohsm__row(p->views, p->view_stride, i))) ||
            (p->tangents && !cohsm__is_unit(cohsm__row(p->tangents, p->tangent_stride, i))))
            return COHSM_ERR_ARGUMENT;
        if ((i == 0 || p->material_stride) && !cohsm__material_valid(cohsm__material_at(p, i)))
            return COHSM_ERR_DESC;
    }
    return COHSM_OK;
}

/* All samples of one point, the first of which is number at. Returns how many have a weight. */
static size_t cohsm__sample_point(const cohsm__estimator *e, uint32_t pixel, const cohsm_samples *out, size_t at)
{
    uint32_t count = e->desc->samples, k, b, block;
    int third = e->aim.light->desc.shape == COHSM_SHAPE_CALLBACK;
    float u[COHSM__SAMPLE_BLOCK][3], scale = 1.0f / (float)count;
    size_t useful = 0;

    for (k = 0; k < count; k += block) {
        block = count - k < COHSM__SAMPLE_BLOCK ? count - k : COHSM__SAMPLE_BLOCK;
        if (e->reachable) {
            for (b = 0; b < block; b++) cohsm__numbers(e->desc, pixel, k + b, third, u[b]);
            cohsm__environment_warm(e, u, block);
        }
        for (b = 0; b < block; b++, at++) {
            cohsm__v3 weight = cohsm__v3_make(0.0f, 0.0f, 0.0f);
            cohsm_emission found;

            memset(&found, 0, sizeof found);
            if (e->reachable) weight = cohsm__v3_scale(cohsm__estimate(e, u[b], &found), scale);
            if (!(found.pdf > 0.0f)) {
                cohsm__v3_store(found.direction, e->surface.n);
                found.distance = COHSM_INFINITY;
            }
            useful += weight.x + weight.y + weight.z > 0.0f;
            memcpy(out->directions + at * 3u, found.direction, sizeof found.direction);
            out->distances[at] = found.distance;
            if (out->coords) memcpy(out->coords + at * 3u, found.coords, sizeof found.coords);
            cohsm__v3_store(out->weights + at * 3u, weight);
        }
    }
    return useful;
}

COHSM_DEF cohsm_result cohsm_sample(const cohsm_sample_desc *desc, const cohsm_emitter *light,
                                    const cohsm_points *points, const cohsm_samples *out, size_t *useful)
{
    cohsm_result result;
    size_t i, n = 0, total;

    if (!desc || !light || !points || !out || !out->directions || !out->distances || !out->weights)
        return COHSM_ERR_ARGUMENT;
    if (desc->samples == 0 || desc->samples > 65536u || (unsigned)desc->sampling > (unsigned)COHSM_SAMPLING_PAPER)
        return COHSM_ERR_DESC;
    if (!cohsm__mul_size(points->count, (size_t)desc->samples * 12u, &total)) return COHSM_ERR_ARGUMENT;
    result = cohsm__points_check(points);
    if (result != COHSM_OK) return result;
    for (i = 0; i < points->count; i++) {
        cohsm__estimator e;
        const float *normal = cohsm__row(points->normals, points->normal_stride, i);
        const float *view = points->views ? cohsm__row(points->views, points->view_stride, i) : normal;
        const float *tangent = points->tangents ? cohsm__row(points->tangents, points->tangent_stride, i) : NULL;
        const float *p = cohsm__row(points->positions, points->position_stride, i);

        cohsm__surface_init(&e.surface, cohsm__material_at(points, i), cohsm__v3_load(normal), tangent,
                            cohsm__v3_load(view));
        e.reachable = cohsm__aim_at(&e.aim, light, cohsm__v3_load(p)) && !e.surface.black;
        cohsm__estimator_init(&e, desc, light);
        n += cohsm__sample_point(&e, points->pixels ? points->pixels[i] : (uint32_t)i, out, i * desc->samples);
    }
    if (useful) *useful = n;
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_accumulate(size_t count, uint32_t samples, const float *weights, const float *visibility,
                                        float *radiance, size_t radiance_stride)
{
    size_t i, c, at = 0;
    uint32_t k;

    if (samples == 0 || (count && (!weights || !radiance)) || !cohsm__stride_valid(radiance_stride, 12))
        return COHSM_ERR_ARGUMENT;
    for (i = 0; i < count; i++) {
        float *out = (float *)(void *)((char *)radiance + (radiance_stride ? radiance_stride : 12u) * i);
        double sum[3] = { 0.0, 0.0, 0.0 };

        for (k = 0; k < samples; k++, at++) {
            const float *w = weights + at * 3u;
            double v;
            if (w[0] == 0.0f && w[1] == 0.0f && w[2] == 0.0f) continue;
            v = visibility ? (double)visibility[at] : 1.0;
            if (!(v > 0.0)) continue;      /* COHSM_REFUSED too */
            for (c = 0; c < 3; c++) sum[c] += v * (double)w[c];
        }
        for (c = 0; c < 3; c++) out[c] += (float)sum[c];
    }
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_progressive_reset(cohsm_progressive *p)
{
    size_t i;
    if (!p || (p->count && !p->sums)) return COHSM_ERR_ARGUMENT;
    for (i = 0; i < p->count; i++) p->sums[i] = 0.0;
    p->frames = 0;
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_progressive_add(cohsm_progressive *p, const float *frame)
{
    size_t i;
    if (!p || (p->count && (!p->sums || !frame)) || p->frames == UINT32_MAX) return COHSM_ERR_ARGUMENT;
    for (i = 0; i < p->count; i++) p->sums[i] += (double)frame[i];
    p->frames++;
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_progressive_mean(const cohsm_progressive *p, float *mean)
{
    size_t i;
    if (!p || (p->count && (!p->sums || !mean)) || p->frames == 0) return COHSM_ERR_ARGUMENT;
    for (i = 0; i < p->count; i++) mean[i] = (float)(p->sums[i] / (double)p->frames);
    return COHSM_OK;
}

/* ---- >>sampling: BRDFs one by one ------------------------------------------------------------------------------ */

static cohsm_result cohsm__brdf_prepare(cohsm__surface *s, const cohsm_material *m, const float *normal,
                                        const float *tangent, const float *wo)
{
    if (!m || !normal || !wo || !cohsm__is_unit(normal) || !cohsm__is_unit(wo) || (tangent && !cohsm__is_unit(tangent)))
        return COHSM_ERR_ARGUMENT;
    if (!cohsm__material_valid(m)) return COHSM_ERR_DESC;
    cohsm__surface_init(s, m, cohsm__v3_load(normal), tangent, cohsm__v3_load(wo));
    return COHSM_OK;
}

static void cohsm__brdf_result(const cohsm__surface *s, cohsm__v3 wi, float *f, float *pdf)
{
    cohsm__response r = cohsm__respond(s, wi);
    cohsm__v3_store(f, cohsm__v3_add(r.diffuse, r.specular));
    *pdf = s->black ? 0.0f : cohsm__brdf_pdf(s, &r);
}

COHSM_DEF cohsm_result cohsm_brdf_eval(const cohsm_material *material, const float normal[3], const float tangent[3],
                                       const float wo[3], const float wi[3], float f[3], float *pdf)
{
    cohsm__surface s;
    cohsm_result result = cohsm__brdf_prepare(&s, material, normal, tangent, wo);

    if (result != COHSM_OK) return result;
    if (!wi || !f || !pdf || !cohsm__is_unit(wi)) return COHSM_ERR_ARGUMENT;
    cohsm__brdf_result(&s, cohsm__to_frame(&s, cohsm__v3_normalize(cohsm__v3_load(wi))), f, pdf);
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_brdf_sample(const cohsm_material *material, const float normal[3],
                                         const float tangent[3], const float wo[3], const float u[2], float wi[3],
                                         float f[3], float *pdf)
{
    cohsm__surface s;
    cohsm__v3 w;
    cohsm_result result = cohsm__brdf_prepare(&s, material, normal, tangent, wo);

    if (result != COHSM_OK) return result;
    if (!u || !wi || !f || !pdf || !cohsm__in(u[0], 0.0f, COHSM__BELOW_1) ||
        !cohsm__in(u[1], 0.0f, COHSM__BELOW_1))
        return COHSM_ERR_ARGUMENT;
    w = cohsm__brdf_draw(&s, s.diffuse_share, u[0], u[1]);
    cohsm__brdf_result(&s, w, f, pdf);
    cohsm__v3_store(wi, *pdf > 0.0f ? cohsm__from_frame(s.t, s.b, s.n, w) : s.n);
    return COHSM_OK;
}

/* >>> shared fp_end: written by tools/stamp from src/shared, edit there */

/* unit fp_end: the user's options again. clang and MSVC keep contraction off to the end of the file. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__)
#pragma GCC pop_options
#endif

/* <<< shared */

#endif /* CSM_IMPLEMENTATION */

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
