/* envshadow.h - v1.0.0 - many directional lights with shadow maps, such as a sky's - MIT-0 OR Unlicense

   What it does

   Takes directional lights, lays out, fits and (on the CPU) renders one shadow map for each, and shades
   arrays of points with all of them in one pass: hundreds of lights that stand for a sky, as envlights.h
   makes them, or your own. The method is that of Knuth and Fuhrmann, "Self-Shadowing of Dynamic Scenes with
   Environment Maps using the GPU", WSCG 2005. Nothing is computed on the geometry beforehand: the geometry
   may deform, tear, be open or intersect itself.

   What it does not do

   - Lights are infinitely far away: no light comes from a place inside the scene. envlights.h turns a sky
     into lights.
   - k shadow maps see k directions. Too few lights show as separate shadow edges, too small maps as jagged
     edges, and light may leak through walls thinner than the filter's radius and four texels.
     docs/envshadow.md has pictures and figures.
   - It computes no bounced light, renders no pictures, opens no files and starts no threads.

   Quick start

   Write the define in exactly one source file; include the header alone everywhere else.

       #define ENVSHADOW_IMPLEMENTATION
       #include "envshadow.h"
       #include <math.h>
       #include <stdio.h>

       static const float corners[] = { -1, 1, -1,  1, 1, -1,  1, 1, 1,  -1, 1, 1 };  // above the floor
       static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2 };

       int main(void)
       {
           static float directions[3 * 64], irradiances[3 * 64];    // a bright sky, as 64 lights
           const float points[] = { 0, 0, 0,  9, 0, 0 }, normals[] = { 0, 1, 0,  0, 1, 0 };
           envsh_lights lights = { 64, directions, irradiances, NULL, NULL, 0 };
           envsh_mesh mesh = { corners, 4, 0, triangles, 6, NULL, NULL, NULL };
           envsh_points receivers = { 2, points, 0, normals, 0, NULL, 0, 0 };
           envsh_maps *maps;
           float light[6];

           for (int i = 0; i < 64; i++) {
               float y = (i + 0.5f) / 64, r = sqrtf(1 - y * y), *d = directions + 3 * i;
               d[0] = r * cosf(2.4f * i), d[1] = y, d[2] = r * sinf(2.4f * i);
               for (int c = 0; c < 3; c++) irradiances[3 * i + c] = 6.2832f / 64;  // 1 x solid angle
           }
           if (envsh_maps_create(NULL, 64, &maps) != ENVSH_OK) return 1;
           envsh_maps_begin(maps, &lights, envsh_bounds_of(&mesh, 1, NULL));            // each frame
           envsh_maps_draw(maps, &mesh, NULL);
           envsh_maps_end(maps);
           envsh_shade(maps, NULL, &receivers, light);
           printf("under the square %.2f, far from it %.2f\n", (double)light[0], (double)light[3]);
           envsh_maps_free(maps);
           return !(light[0] < 2 && light[3] > 3);
       }

   Conventions

   Coordinates are right-handed, and any axis may be up; matrices are column-major float[16]; directions have
   unit length and point from the surface to the light; distances are in your units, angles in radians,
   irradiance in W/m^2. A vector that is called unit may have a length from 0.97 to 1.03 and is used as it is;
   any other length is an error, and the log names the element.

     light      a directional light: direction, irradiance, and extent
     extent     how far a light spreads about its direction, as the sun's disc or a region of the sky does: an
                ellipse, given by two half axes whose lengths are tangents of angles. A light without extent
                casts sharp shadows
     map        a light's shadow map
     atlas      the texture, of one or several pages, that holds the maps of all lights
     tile       the place of one light's map in the atlas; with rgba four tiles lie in the same texels, each
                in a channel of its own
     guard      texels around each tile that are never drawn into, so that filters find no caster there and
                not a neighbouring tile
     caster     geometry that is drawn into shadow maps
     receiver   a point that is shaded
     depth      0 nearest to the light .. 1 farthest caster, linear in distance; 1 or more means no caster

   How it works

   Each light has one orthographic map, which is fitted to the casters' bounds. Sizes go in steps of a
   sixteenth of an octave and corners lie on whole texels, so that small changes of the bounds move no texel
   of a resting light. A receiver is moved along its normal, by bias texels at grazing light and a quarter of
   that at light from straight above. Each tap of a filter then compares the stored depth with the depth of
   the receiver's plane at that tap, so that grazing light needs no larger bias than that. Tiles are divided
   into cells of 8 x 8 texels with the least and greatest depth of each, by which most filters need no texel.

   From the paper to the code

     3, importance sampling                envlights.h                                        -
     3, algorithm 1, all lights at once    envsh_maps_begin envsh_maps_draw envsh_shade       T23
     3, algorithm 2, clusters of c lights  envsh_illuminate                                   -
     3, Fig. 2, maps side by side          envsh__lay_out_tiles envsh_views                   T24
     3, Fig. 3, more lights, softer shadow envsh_maps_desc envsh_shade                        T23
     3, Fig. 4, smoothing                  envsh__filter_smooth                               image
     4, Fig. 5, maps in color channels     rgba of envsh_maps_desc                            T24
     4, percentage closer filtering        envsh__filter_taps                                 T24
     4, load balancing                     envsh_cost_fit envsh_cost_cluster                  -
     6, size of the light source           envsh__filter_penumbra, axes_u of envsh_lights     image

   The last column names the rows of docs/conformance.md that test a line; a - says that there is none. Of
   these, tests/envshadow/maps_rows_test.c holds clusters to the sums of all lights at once, and the cost
   model to its own times.

   The knobs, and what each trades:

     lights        With few lights the shadow edges of single lights can be seen (Fig. 3 of the paper); time
                   and memory grow with k.
     map_side      Fewer texels give jagged contact shadows and leaks through thin walls; memory grows with
                   the square of map_side.
     filter        PLAIN is sharp. SMOOTH and PCF, the paper's, blur every edge alike. PENUMBRA, the paper's
                   future work, blurs by the light's extent and the distance of the occluder, and so needs the
                   fewest lights for a picture.
     radius        PENUMBRA looks no farther than radius texels: with too few, shadows of a large sun stay
                   sharp far from their casters.
     bias          Too little gives acne; too much lets light under things that touch the ground.

   Maps take 4 bytes for each of the map_side^2 texels of each light, and a 32nd of that for the depth bounds
   of cells.

   Configuration

     ENVSHADOW_IMPLEMENTATION   in one source file: compiles the code
     ENVSH_STATIC               beside it: a private copy for this file, all functions static
     ENVSH_DEF                  everywhere: your own linkage instead

   Memory, errors, threads, determinism

   All memory comes from the allocator in desc.system, called from the thread that called us. Every function
   that can fail returns an envsh_result; if the result is not ENVSH_OK, outputs are untouched (unless a
   contract says otherwise), nothing leaks, and desc.system.log is told which field or element is wrong. There
   are no globals: any number of threads may shade with the same maps at once; a call that changes maps needs
   them to itself. Maps and shading have the same bytes on every compiler, byte order and thread count (not
   with x87 arithmetic, nor clang's -ffast-math).

   Cost: docs/measured/envshadow.md, build/bench gl_envshadow.   History: CHANGELOG.md.
   Licence: end of this file. */
#ifndef ENVSHADOW_H
#define ENVSHADOW_H

#define ENVSH_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "envshadow.h needs C99 or C++11"
#endif
#if defined(ENVSH_STATIC) && !defined(ENVSHADOW_IMPLEMENTATION)
#error "ENVSH_STATIC makes all functions private: ENVSHADOW_IMPLEMENTATION belongs into the same file"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef ENVSH_DEF
#ifdef ENVSH_STATIC
#define ENVSH_DEF static inline
#else
#define ENVSH_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/envshadow/api.h ==== */

/* ---- page one: lights, casters and points become irradiance ---- */

#define ENVSH_RESULTS(X)                                                                                     \
    X(ENVSH_OK, "ok")                                                                                        \
    X(ENVSH_ERR_ARGUMENT, "a pointer is NULL, or a count or stride is out of range")                         \
    X(ENVSH_ERR_DESC, "a field of a desc is out of range")                                                   \
    X(ENVSH_ERR_INPUT, "the data cannot be used")                                                            \
    X(ENVSH_ERR_ALLOC, "the allocator returned no memory")                                                   \
    X(ENVSH_ERR_MEMORY, "the caller's memory is too small or misaligned")                                    \
    X(ENVSH_ERR_LIMIT, "a size overflows or passes a limit")                                                 \
    X(ENVSH_ERR_CANCELLED, "cancelled by the progress callback")                                             \
    X(ENVSH_ERR_ORDER, "this call comes too early, too late or twice")                                       \
    X(ENVSH_ERR_FORMAT, "not a file of this kind, or a damaged one")                                         \
    X(ENVSH_ERR_VERSION, "a file of an unknown version")                                                     \
    X(ENVSH_ERR_MISMATCH, "what was given does not belong together")

typedef enum envsh_result {
#define ENVSH__ENUM(name, text) name,
    ENVSH_RESULTS(ENVSH__ENUM)
#undef ENVSH__ENUM
    ENVSH_RESULT_COUNT
} envsh_result;

typedef struct envsh_bounds { float low[3], high[3]; } envsh_bounds;    /* a box in world space */

typedef struct envsh_maps envsh_maps;               /* shadow maps of some lights */
typedef struct envsh_lights envsh_lights;           /* arrays of directional lights: below */
typedef struct envsh_mesh envsh_mesh;               /* triangles that cast shadows: below */
typedef struct envsh_points envsh_points;           /* arrays of receivers: below */
typedef struct envsh_maps_desc envsh_maps_desc;     /* how large the maps are: below */
typedef struct envsh_query envsh_query;             /* how the maps are filtered: below */

ENVSH_DEF envsh_result envsh_maps_create(const envsh_maps_desc *desc, uint32_t capacity, envsh_maps **out);
/* Makes shadow maps, *out, without any light as yet. Give them back by envsh_maps_free.
   desc      NULL = all defaults: 256 x 256 texels a light
   capacity  how many lights the maps hold at once, 0..ENVSH_MAX_LIGHTS; envsh_illuminate takes more lights
   Errors    ENVSH_ERR_ARGUMENT: out is NULL, or capacity is too large. ENVSH_ERR_DESC: a field is out of
             range. ENVSH_ERR_LIMIT: size_t cannot count the texels. ENVSH_ERR_ALLOC: there is no memory. */

ENVSH_DEF envsh_result envsh_maps_begin(envsh_maps *maps, const envsh_lights *lights, envsh_bounds bounds);
/* Begins a frame of these lights (NULL = none): clears tiles and fits them to the bounds of the casters.
   Parts of casters outside the bounds are cut off, but parts nearer to the light are kept at depth 0. Empty
   bounds (low > high) mean that nothing casts shadows.
   Errors  ENVSH_ERR_ARGUMENT: maps or an array is NULL, the stride is out of range, or there are axes_u
           without axes_v. ENVSH_ERR_LIMIT: count is above the capacity. ENVSH_ERR_INPUT: a light is not
           finite, its direction is not unit, or an axis is 1e3 long or longer; the bounds are not finite or
           beyond 1e15. */

ENVSH_DEF envsh_result envsh_maps_draw(envsh_maps *maps, const envsh_mesh *mesh, const float transform[16]);
/* Renders the depth of a mesh into the tile of every light: at texel centres, by the top-left rule, both
   sides. Triangles with a vertex that is not finite are left out.
   transform  mesh to world, affine; NULL = identity
   Errors     ENVSH_ERR_ARGUMENT: a pointer is NULL, or a count or stride is wrong. ENVSH_ERR_INPUT: an index
              is not below vertex_count, or transform is not affine. ENVSH_ERR_LIMIT: the mesh is too large.
              ENVSH_ERR_ORDER: envsh_maps_begin must come first. ENVSH_ERR_MISMATCH: the maps have no_depth.
              ENVSH_ERR_CANCELLED: some tiles may have the mesh; begin the frame anew. */

ENVSH_DEF envsh_result envsh_maps_end(envsh_maps *maps);
/* Makes the maps ready for shading, after all casters are drawn, and again after each later change of a tile.
   Errors  ENVSH_ERR_ARGUMENT: maps is NULL. ENVSH_ERR_ORDER: envsh_maps_begin must come first.
           ENVSH_ERR_MISMATCH: the maps have no_depth. */

ENVSH_DEF envsh_result envsh_shade(const envsh_maps *maps, const envsh_query *query,
                                   const envsh_points *points, float *irradiance);
/* Writes for each point the sum over all lights of visibility x cosine x irradiance, which times albedo / pi
   is the radiance of a diffuse surface. A point or normal that is not finite gives 0.
   query       NULL = all defaults
   irradiance  receives 3 floats for each point, W/m^2
   Errors      ENVSH_ERR_ARGUMENT: a pointer is NULL, or a stride is out of range.
               ENVSH_ERR_DESC: a field of the query is out of range.
               ENVSH_ERR_INPUT: a normal is not unit.
               ENVSH_ERR_MISMATCH: the maps have no_depth.
               ENVSH_ERR_ORDER: envsh_maps_end must come first.
               ENVSH_ERR_CANCELLED: some points may have been written.
   Cost        time grows with points x lights x taps, but for points whose shadow the cells decide: blocks of
               texels whose least and greatest depth envsh_maps_end finds */

ENVSH_DEF void envsh_maps_free(envsh_maps *maps);
/* Gives back the maps and their memory. NULL is allowed. */

ENVSH_DEF envsh_bounds envsh_bounds_of(const envsh_mesh *meshes, size_t count, const float *transforms);
/* Returns the box, in world space, of all finite vertices of the meshes; low > high if there are none.
   transforms  16 floats for each mesh, mesh to world, affine; NULL = identity */

/* ---- structs of page one ---- */

struct envsh_lights {               /* directional lights: your own, or those that envlights.h makes of a sky
                                       (stride sizeof(envlt_light)) */
    uint32_t     count;
    const float *directions;        /* x, y, z of each light, unit, towards the light */
    const float *irradiances;       /* red, green, blue on a plane that faces the light, -1e32..1e32 W/m^2 */
    const float *axes_u, *axes_v;   /* extent: half axes of the ellipse over which the light spreads, at right
                                       angles to the light's direction. Lengths are tangents of angles, below
                                       1e3. Both NULL = no extent: sharp shadows */
    size_t       stride;            /* bytes from one light to the next in each of the arrays, a multiple of
                                       4, >= 12; 0 = 12 */
};

typedef int (*envsh_mask_fn)(void *user, uint32_t triangle, const float weights[3]);
/* A function of yours that says whether a triangle is there: not 0, or 0 in a hole of its alpha mask. The
   weights of the triangle's corners, which add up to 1, say at which point. parallel_for's threads call the
   function. */

struct envsh_mesh {                 /* triangles that cast shadows */
    const float    *positions;      /* x, y, z of each vertex */
    size_t          vertex_count;
    size_t          vertex_stride;  /* bytes from one vertex to the next, a multiple of 4, >= 12; 0 = 12 */
    const uint32_t *indices;        /* three to a triangle; NULL = indices16, or else 0, 1, 2, ... */
    size_t          index_count;    /* a multiple of 3 (ignored without indices: vertex_count is used) */
    const uint16_t *indices16;      /* in place of indices; not both */
    envsh_mask_fn   mask_fn;        /* holes of an alpha mask, asked for at centres of texels; NULL = none */
    void           *user;           /* given to mask_fn */
};

struct envsh_points {               /* receivers */
    size_t       count;
    const float *positions;         /* x, y, z of each, world space */
    size_t       position_stride;   /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const float *normals;           /* unit shading normals, for the cosine; 0 0 0: no receiver, its results
                                       are 0 */
    size_t       normal_stride;     /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const float *geometric_normals; /* unit normals of the triangles, which say on which side of a surface a
                                       light is and where the bias moves a point; NULL = normals. 0 0 0: no
                                       receiver, its results are 0 */
    size_t       geometric_normal_stride;   /* bytes, a multiple of 4, >= 12; 0 = 12 */
    uint32_t     first;             /* the number of point 0, for pictures that are shaded in parts: point i
                                       turns the taps of its filter by query.seed and first + i */
};

/* ---- results; memory, threads, progress, log: the caller's ---- */

ENVSH_DEF const char *envsh_result_text(envsh_result result);
/* Returns a constant string that says what a result means; "unknown result" for a number that is none. */

typedef struct envsh_allocator {    /* all zero: malloc and free; else both functions */
    void *(*alloc_fn)(size_t bytes, void *user);    /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} envsh_allocator;

typedef void (*envsh_task)(void *context, size_t index);

typedef struct envsh_system {       /* all zero: malloc and free, this thread alone, no progress, no log */
    envsh_allocator allocator;      /* called from the thread that called us */
    void (*parallel_for)(void *user, size_t count, envsh_task task, void *context);
    /* Must call task(context, i) once for each i < count, in any order and on any threads, and return when
       all are done. What is computed does not depend on the threads. */
    int (*progress)(void *user, float fraction);
    /* Called from the thread that called us, fraction 0..1 never falling within a call; not 0 cancels. */
    void (*log)(void *user, const char *message);
    /* Called at most once by a call that fails, from the thread that called us, before it returns: one line
       without a line end that names the function, the field or element, its value and its range. */
    void *user;                     /* given to parallel_for, progress and log */
} envsh_system;

/* ---- settings ---- */

#define ENVSH_MAX_LIGHTS 8192u      /* the most lights that maps hold at once */
#define ENVSH_MAX_TAPS 64u          /* the most taps of a query */

typedef enum envsh_rows {
    ENVSH_ROWS_DEFAULT,             /* = ENVSH_ROWS_BOTTOM_FIRST */
    ENVSH_ROWS_BOTTOM_FIRST,        /* row 0 of a texture is at clip y = -1: OpenGL, Vulkan */
    ENVSH_ROWS_TOP_FIRST,           /* row 0 of a texture is at clip y = +1: Direct3D, Metal */
    ENVSH_ROWS_COUNT
} envsh_rows;

typedef enum envsh_clip_depth {
    ENVSH_CLIP_DEPTH_DEFAULT,               /* = ENVSH_CLIP_DEPTH_MINUS_ONE_TO_ONE */
    ENVSH_CLIP_DEPTH_MINUS_ONE_TO_ONE,      /* OpenGL; its depth buffers hold 0 near .. 1 far */
    ENVSH_CLIP_DEPTH_ZERO_TO_ONE,           /* Direct3D, Metal, Vulkan */
    ENVSH_CLIP_DEPTH_REVERSED,              /* 1 near .. 0 far, in depth buffers too */
    ENVSH_CLIP_DEPTH_COUNT
} envsh_clip_depth;

struct envsh_maps_desc {            /* zero it, then set what you care about */
    envsh_system system;            /* envsh_maps_draw, envsh_shade and envsh_visible each call progress with
                                       fractions from 0 to 1. In envsh_illuminate the fraction goes from 0 to
                                       1 once: it rises while points are shaded, and stays where it is while
                                       draw_fn draws */
    uint32_t map_side;              /* texels a side of a tile, guard included, 16..4096; 0 = 256 */
    uint32_t guard;                 /* empty texels on each side of a tile, 1..map_side / 4; 0 = 4 */
    uint32_t max_side;              /* the most texels a side of the atlas, map_side..32768; 0 = 8192, or
                                       map_side if that is more. Tiles that do not fit go to further pages */
    int      rgba;                  /* not 0: four tiles share texels, each in a channel of its own */
    int      no_depth;              /* not 0: layout and matrices only, for maps that your GPU renders */
    envsh_rows       rows;          /* which row comes first in the textures that your GPU renders by
                                       envsh_view.world_to_clip */
    envsh_clip_depth clip_depth;    /* the depth that envsh_view.world_to_clip makes, and that
                                       envsh_maps_set takes */
};

typedef enum envsh_filter {         /* which texels of a map answer for a point */
    ENVSH_FILTER_DEFAULT,           /* = ENVSH_FILTER_PENUMBRA */
    ENVSH_FILTER_PLAIN,             /* the texel that the point falls into */
    ENVSH_FILTER_SMOOTH,            /* the paper's smoothing: all texels within radius, with weights that fall
                                       linearly */
    ENVSH_FILTER_PCF,               /* the paper's percentage closer filtering: taps on a disc of the radius
                                       `radius`, turned by another angle at each point */
    ENVSH_FILTER_PENUMBRA,          /* taps on an ellipse as large as the penumbra, which is the light's
                                       extent times the distance to the occluders that a first set of taps
                                       finds */
    ENVSH_FILTER_COUNT
} envsh_filter;

struct envsh_query {                /* zero it, then set what you care about */
    envsh_filter filter;
    uint32_t     tap_count;         /* of PCF and PENUMBRA, 1..ENVSH_MAX_TAPS; 0 = 16 */
    float        radius;            /* texels. SMOOTH: 0.5..8, 0 = 2; PCF: up to 32, 0 = 2, negative = none;
                                       PENUMBRA: the largest half axis, up to 64, 0 = 12, negative = none */
    float        bias;              /* texels, up to 1e6, by which a point is moved along its geometric normal
                                       at grazing light; 0 = 1, negative = none */
    float        extent_scale;      /* PENUMBRA: factor on the lights' extents, up to 1e6; 0 = 1, negative =
                                       no extent */
    uint32_t     seed;              /* another seed turns the taps by other angles */
    int          add;               /* not 0: envsh_shade adds to the output */
};

/* ---- one light, clusters of lights ---- */

ENVSH_DEF envsh_result envsh_visible(const envsh_maps *maps, uint32_t light, const envsh_query *query,
                                     const envsh_points *points, float *visible);
/* Writes how much of one light reaches each point, 0..1, for a BRDF of your own; 0 if the light is behind the
   geometric surface.
   light    its number in the arrays of envsh_maps_begin
   query    NULL = all defaults; add is ignored
   visible  receives a float for each point
   Errors   those of envsh_shade.
            ENVSH_ERR_ARGUMENT: also if the maps do not hold the light. */

typedef envsh_result (*envsh_draw_fn)(void *user, envsh_maps *maps);
/* Must call envsh_maps_draw or envsh_maps_set for everything that casts shadows, and return ENVSH_OK; another
   result ends envsh_illuminate, which returns it. */

ENVSH_DEF envsh_result envsh_illuminate(envsh_maps *maps, const envsh_lights *lights, envsh_bounds bounds,
                                        envsh_draw_fn draw_fn, void *user, const envsh_query *query,
                                        const envsh_points *points, float *irradiance);
/* Shades points with more lights than the maps hold, by the paper's algorithm 2: takes the lights in clusters
   of as many as there is capacity, has draw_fn draw the maps of a cluster, and adds the cluster's light to
   the points. With a capacity for all lights this is algorithm 1. The sums are the same, to the bit, for
   every capacity.
   maps        receive the lights of each cluster; envsh_maps_begin and envsh_maps_end are called for you
   bounds      of the casters, as for envsh_maps_begin
   draw_fn     is called once for each cluster, with user
   query       NULL = all defaults
   irradiance  receives 3 floats for each point, as from envsh_shade
   Errors      those of envsh_maps_begin and envsh_shade, checked before anything is drawn, and the result of
               draw_fn. After an error of draw_fn or ENVSH_ERR_CANCELLED some clusters may have been added.
               ENVSH_ERR_ARGUMENT: also if draw_fn is NULL. ENVSH_ERR_LIMIT: the capacity is 0, and there are
               lights. */

/* ---- maps for and from your own renderer ---- */

typedef struct envsh_view {         /* one light's shadow map, for a renderer or a shader of your own */
    float    world_to_clip[16];     /* world to clip space of the tile's viewport */
    float    lookup[12];            /* three rows of 4, which take a point of the world to x and y, in texels
                                       from the tile's corner, and to depth */
    float    right[3], up[3];       /* unit axes of the tile's x and y, at right angles to the direction */
    float    direction[3], irradiance[3];
    float    texel[2];              /* size of a texel in the world, in x and y */
    float    depth_range;           /* distance in the world from depth 0 to depth 1 */
    float    spread[4];             /* the light's extent in texels of the tile, for an occluder whose depth
                                       is less by 1: x, y of axis_u, then x, y of axis_v */
    uint32_t x, y, page, channel;   /* where the tile lies in the atlas; x, y are texels of its corner */
    uint32_t guard;                 /* texels on each side of the tile that have to stay empty */
} envsh_view;

typedef struct envsh_info {         /* the atlas */
    uint32_t width, height;         /* texels of a page */
    uint32_t page_count;
    uint32_t channel_count;         /* 1, or 4 with rgba */
    uint32_t map_side, guard, capacity;
    float   *depth;                 /* channel_count floats a texel, row by row, page by page: 0 near .. 1
                                       far. NULL with no_depth */
    size_t   bytes;                 /* of memory that the maps keep */
} envsh_info;

ENVSH_DEF void envsh_get_info(const envsh_maps *maps, envsh_info *out);
/* Writes how the tiles lie in memory. Does nothing if a pointer is NULL. */

ENVSH_DEF const envsh_view *envsh_views(const envsh_maps *maps, uint32_t *count);
/* Returns an array with a view for each light of the last envsh_maps_begin, valid until the next, and writes
   how many there are.
   maps   NULL gives NULL and a count of 0
   count  may be NULL */

ENVSH_DEF envsh_result envsh_maps_set(envsh_maps *maps, uint32_t light, const float *depth,
                                      size_t row_stride);
/* Copies the depths of one light's tile from a renderer of your own. The guard stays empty whatever is given,
   and NaN means no caster.
   light       its number in the arrays of envsh_maps_begin
   depth       map_side rows of map_side depths, row 0 at y = 0, as clip_depth of envsh_maps_desc says
   row_stride  bytes from one row to the next, a multiple of 4; 0 = packed
   Errors      ENVSH_ERR_ARGUMENT: a pointer is NULL, the maps do not hold the light, or row_stride is out of
               range.
               ENVSH_ERR_ORDER: envsh_maps_begin must come first.
               ENVSH_ERR_MISMATCH: the maps have no_depth. */

typedef struct envsh_tile {         /* a tile in your memory, for envsh_visibility_twin */
    const envsh_view *view;
    const float      *depth;        /* the tile's corner texel, in its channel; 0 near .. 1 far */
    size_t            row_stride, texel_stride;    /* bytes, multiples of 4 */
    uint32_t          side;         /* texels a side */
} envsh_tile;

ENVSH_DEF float envsh_visibility_twin(const envsh_tile *tile, const envsh_query *query, const float point[3],
                                      const float geometric_normal[3], uint32_t index);
/* Returns how much of one tile's light reaches one point, 0..1, read from depths in your memory: the twin in
   C of the shader function in gl_envshadow.h, with which you can compare a shader that you wrote for another
   API. The answers are those of envsh_visible, which saves reads by cells. Returns 0, and logs nothing, if a
   pointer is NULL, if envsh_visible would refuse the query, or if the normal is not unit.
   query   NULL = all defaults
   index   the number of the point, by which its taps are turned */

/* ---- how many lights a pass: the cost model ---- */

typedef struct envsh_cost {         /* milliseconds of which a frame of k lights in clusters of c is made:
                                       passes x pass + passes x c x slot, with passes = ceil(k / c) */
    double pass;                    /* for each pass: state, geometry, fetching the surface */
    double slot;                    /* for each place for a light in a pass, filled or not */
} envsh_cost;

ENVSH_DEF int envsh_cost_fit(uint32_t light_count, const uint32_t *clusters, const double *ms, size_t count,
                             envsh_cost *out);
/* Finds the costs by least squares through measured times of a frame. Returns 1; returns 0 and leaves *out
   untouched if the times do not determine the costs, or if an argument is NULL or 0.
   light_count  k, in all measurements
   clusters     count of them, the c of each measurement, > 0; at least two that differ
   ms           the milliseconds of each measurement, 0..1e12 */

ENVSH_DEF uint32_t envsh_cost_cluster(const envsh_cost *cost, uint32_t light_count, uint32_t most);
/* Returns the c of 1..most for which a frame costs least; among equals the smallest, which needs the least
   memory. Returns 1 if an argument is NULL or 0.
   most    as many as your atlas, uniforms or instruction limit allow */

#ifdef __cplusplus
}
#endif

#endif /* ENVSHADOW_H */

/* ==== src/envshadow/begin.h ==== */

/* ==== implementation ==================================================================================== */

#if defined(ENVSHADOW_IMPLEMENTATION) && !defined(ENVSHADOW_IMPLEMENTED)
#define ENVSHADOW_IMPLEMENTED

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
#define ENVSH__FINITE_MATH 1
#else
#define ENVSH__FINITE_MATH 0
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

typedef struct envsh__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} envsh__allocator;

static inline void *envsh__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void envsh__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
static inline int envsh__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

/* Returns 1 if the functions of a public allocator are both there or both NULL. */
static inline int envsh__allocator_valid(void *(*alloc_fn)(size_t, void *), void (*free_fn)(void *, void *))
{
    return (alloc_fn == NULL) == (free_fn == NULL);
}

static inline envsh__allocator envsh__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    envsh__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : envsh__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : envsh__default_free;
    a.user = user;
    return a;
}

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *envsh__alloc(const envsh__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *envsh__alloc_array(const envsh__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return envsh__mul_size(count, item_size, &size) ? envsh__alloc(a, size) : NULL;
}

static inline void envsh__free(const envsh__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/message.h ==== */

/* unit message: one line for the caller's log that says why a call failed */

/* ENVSH__COLD stands before functions that are needed only by calls that fail: compilers make these functions
   small, and take branches to them for unlikely. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define ENVSH__COLD __attribute__((cold))
#else
#define ENVSH__COLD
#endif

/* Where a message goes, and the name of the function that failed. If log is NULL, nothing is written. */
typedef struct envsh__logger {
    void (*log)(void *user, const char *message);
    void *user;
    const char *function;
} envsh__logger;

typedef struct envsh__message { char text[256]; size_t used; } envsh__message;

/* Appends a text; what does not fit is cut off. */
static inline ENVSH__COLD void envsh__message_text(envsh__message *m, const char *s)
{
    while (*s && m->used + 1 < sizeof m->text) m->text[m->used++] = *s++;
    m->text[m->used] = 0;
}

static inline ENVSH__COLD void envsh__message_count(envsh__message *m, uint64_t value)
{
    char digits[24];
    size_t at = sizeof digits - 1;
    digits[at] = 0;
    do digits[--at] = (char)('0' + (int)(value % 10));
    while ((value /= 10) != 0);
    envsh__message_text(m, digits + at);
}

/* Writes six significant digits without the zeros at their end. Returns how many digits are left and writes
   *exponent, the power of ten of the first one. value is finite and above 0. */
static inline ENVSH__COLD int envsh__message_digits(double value, char digits[8], int *exponent)
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
static inline ENVSH__COLD void envsh__message_number(envsh__message *m, double value)
{
    char digits[8], first[2] = { 0, 0 };
    int exponent, count, i;

    if (value != value) {
        envsh__message_text(m, "not a number");
        return;
    }
    if (value < 0.0) envsh__message_text(m, "-");
    if (value < 0.0) value = -value;
    if (!(value > 0.0) || value > 1.7976931348623157e308) {
        envsh__message_text(m, value > 0.0 ? "infinity" : "0");
        return;
    }
    if (value < 9007199254740992.0 && value - (double)(uint64_t)value <= 0.0) {
        envsh__message_count(m, (uint64_t)value);
        return;
    }
    count = envsh__message_digits(value, digits, &exponent);
    first[0] = digits[0];
    if (exponent < -4 || exponent > 9) {
        envsh__message_text(m, first);
        if (count > 1) envsh__message_text(m, ".");
        envsh__message_text(m, digits + 1);
        envsh__message_text(m, exponent < 0 ? "e-" : "e");
        envsh__message_count(m, (uint64_t)(exponent < 0 ? -exponent : exponent));
        return;
    }
    if (exponent < 0) envsh__message_text(m, "0.");
    for (i = exponent; i < -1; i++) envsh__message_text(m, "0");
    for (i = 0; i < count; i++) {
        if (exponent >= 0 && i == exponent + 1) envsh__message_text(m, ".");
        first[0] = digits[i];
        envsh__message_text(m, first);
    }
    for (i = count; i <= exponent; i++) envsh__message_text(m, "0");
}

/* Begins a line: "FUNCTION: FIELD". */
static inline ENVSH__COLD void envsh__message_begin(envsh__message *m,
                                          const envsh__logger *logger, const char *field)
{
    m->used = 0;
    envsh__message_text(m, logger->function);
    envsh__message_text(m, ": ");
    envsh__message_text(m, field);
}

/* Logs "FUNCTION: FIELD TEXT", as in "cohsm_build: mesh.positions is NULL". */
static inline ENVSH__COLD void envsh__log_text(const envsh__logger *logger, const char *field, const char *text)
{
    envsh__message m;
    if (!logger->log) return;
    envsh__message_begin(&m, logger, field);
    envsh__message_text(&m, " ");
    envsh__message_text(&m, text);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: FIELD is VALUE; it must be WANTED", as in "cohsm_build: desc.map_side is 3; it must be 0 or
   4..1024". */
static inline ENVSH__COLD void envsh__log_value(const envsh__logger *logger, const char *field, double value,
                                      const char *wanted)
{
    envsh__message m;
    if (!logger->log) return;
    envsh__message_begin(&m, logger, field);
    envsh__message_text(&m, " is ");
    envsh__message_number(&m, value);
    envsh__message_text(&m, "; it must be ");
    envsh__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: ARRAY[INDEX] WHAT VALUE; it must be WANTED", as in "rsm_gather: normals[17] has the length
   0.5; it must be 1 (0.97..1.03), or 0". */
static inline ENVSH__COLD void envsh__log_element(const envsh__logger *logger, const char *array, uint64_t index,
                                        const char *what, double value, const char *wanted)
{
    envsh__message m;
    if (!logger->log) return;
    envsh__message_begin(&m, logger, array);
    envsh__message_text(&m, "[");
    envsh__message_count(&m, index);
    envsh__message_text(&m, "] ");
    envsh__message_text(&m, what);
    envsh__message_text(&m, " ");
    envsh__message_number(&m, value);
    envsh__message_text(&m, "; it must be ");
    envsh__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: mesh: index 2 of triangle 17 is 90, but the mesh has 80 vertices". position counts the
   indices from 0. */
static inline ENVSH__COLD void envsh__log_index(const envsh__logger *logger, const char *mesh,
                                      uint64_t position, uint64_t index, uint64_t vertex_count)
{
    envsh__message m;
    if (!logger->log) return;
    envsh__message_begin(&m, logger, mesh);
    envsh__message_text(&m, ": index ");
    envsh__message_count(&m, position % 3);
    envsh__message_text(&m, " of triangle ");
    envsh__message_count(&m, position / 3);
    envsh__message_text(&m, " is ");
    envsh__message_count(&m, index);
    envsh__message_text(&m, ", but the mesh has ");
    envsh__message_count(&m, vertex_count);
    envsh__message_text(&m, vertex_count == 1 ? " vertex" : " vertices");
    logger->log(logger->user, m.text);
}

/* ==== src/shared/bound.h ==== */

/* unit bound, needs message: the line for a number that is beyond what an object or an earlier call allows */

/* Logs "FUNCTION: FIELD is VALUE; it must be RELATION BOUND, NAME", as in "cohsm_view: view is 9; it must be
   below 8, the number of views". */
static inline ENVSH__COLD void envsh__log_bound(const envsh__logger *logger, const char *field, uint64_t value,
                                      const char *relation, uint64_t bound, const char *name)
{
    envsh__message m;
    m.used = 0;
    envsh__message_text(&m, relation);
    envsh__message_text(&m, " ");
    envsh__message_count(&m, bound);
    envsh__message_text(&m, ", ");
    envsh__message_text(&m, name);
    envsh__log_value(logger, field, (double)value, m.text);
}

/* ==== src/shared/v3.h ==== */

/* unit v3: three floats */

/* tcc 0.9.27 stores a returned struct of 12 bytes as 16, over the caller's next variable. */
typedef struct envsh__v3 {
    float x, y, z;
#ifdef __TINYC__
    float unused;
#endif
} envsh__v3;

static inline envsh__v3 envsh__v3_make(float x, float y, float z)
{
    envsh__v3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

static inline envsh__v3 envsh__v3_load(const float *p) { return envsh__v3_make(p[0], p[1], p[2]); }
static inline void envsh__v3_store(float *p, envsh__v3 v) { p[0] = v.x; p[1] = v.y; p[2] = v.z; }

static inline envsh__v3 envsh__v3_scale(envsh__v3 a, float s)
{
    return envsh__v3_make(a.x * s, a.y * s, a.z * s);
}

/* Returns a + b s. */
static inline envsh__v3 envsh__v3_madd(envsh__v3 a, envsh__v3 b, float s)
{
    return envsh__v3_make(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s);
}

static inline float envsh__v3_dot(envsh__v3 a, envsh__v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float envsh__v3_length(envsh__v3 a)
{
    return sqrtf(envsh__v3_dot(a, a));
}

/* Returns a with length 1. The largest component scales the others first, so that neither tiny nor huge
   vectors leave the range of floats. The zero vector stays zero. */
static inline envsh__v3 envsh__v3_normalize(envsh__v3 a)
{
    float x = fabsf(a.x), y = fabsf(a.y), z = fabsf(a.z), m = x > y ? x : y;
    m = m > z ? m : z;
    if (!(m > 0.0f)) return envsh__v3_make(0.0f, 0.0f, 0.0f);
    if (m < 1e-30f) {
        a = envsh__v3_scale(a, 1e30f);
        m *= 1e30f;
    }
    a = envsh__v3_make(a.x / m, a.y / m, a.z / m);
    m = envsh__v3_length(a);
    return envsh__v3_make(a.x / m, a.y / m, a.z / m);
}

/* Returns 1 if x is finite, by its exponent bits: under -ffast-math compilers may take isfinite() for always
   true. */
static inline int envsh__finite(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7f800000u) != 0x7f800000u;
}

static inline int envsh__v3_finite(envsh__v3 a)
{
    return envsh__finite(a.x) && envsh__finite(a.y) && envsh__finite(a.z);
}

/* Writes b1 and b2, which are orthonormal and right-handed together with a unit n; n.z may be -0 or -1. Duff
   et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017. */
static inline void envsh__v3_basis(envsh__v3 n, envsh__v3 *b1, envsh__v3 *b2)
{
    float s = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + n.z), b = n.x * n.y * a;
    *b1 = envsh__v3_make(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
    *b2 = envsh__v3_make(b, s + n.y * n.y * a, -n.y);
}

/* ==== src/shared/unit.h ==== */

/* unit unit: which vectors count as unit, the same in every header (src/README.md, "Unit vectors") */

/* The squares of the least and the greatest length that count as 1: an 8-bit normal map makes such
   vectors. */
#define ENVSH__UNIT_LEAST2 0.9409f       /* 0.97^2 */
#define ENVSH__UNIT_MOST2 1.0609f        /* 1.03^2 */

/* Says whether a vector is unit, by the square of its length. If that is not a number, the vector is not. */
static inline int envsh__is_unit2(float length2)
{
    return length2 >= ENVSH__UNIT_LEAST2 && length2 <= ENVSH__UNIT_MOST2;
}

/* ==== src/shared/m4.h ==== */

/* unit m4, needs v3: column-major 4 x 4 matrices, float[16], affine */

static inline envsh__v3 envsh__m4_point(const float *m, envsh__v3 p)
{
    return envsh__v3_make(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12],
                     m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                     m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]);
}

/* Returns 1 if a matrix is finite and its last row is 0 0 0 1. */
static inline int envsh__m4_is_affine(const float *m)
{
    int i;
    for (i = 0; i < 16; i++)
        if (!envsh__finite(m[i])) return 0;
    return m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f && m[15] == 1.0f;
}

/* ==== src/shared/trig.h ==== */

/* unit trig: elementary functions with the same bits on every machine */

/* These functions use + - * / and sqrt alone, which IEEE 754 rounds the same everywhere as long as nothing
   is contracted (unit fp_begin). Coefficients are minimax fits of our own. The float functions are free of
   branches and calls, so that loops over them vectorise at SSE2 level. The errors named below are the
   largest differences from the double functions, over all float arguments or a dense set
   (tests/shared/units_test.c). Arguments out of range and NaN are clamped into the range, so that nothing
   here is undefined or returns NaN. */

static inline float envsh__from_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline uint32_t envsh__to_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* Writes sine and cosine of |x| <= 8192 with an absolute error of 1e-7. As in Cody and Waite, pi/2 has three
   parts, of which the first two times k are exact for |k| < 2^13. */
static inline void envsh__sincos(float x, float *sine, float *cosine)
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

/* ==== src/shared/rng.h ==== */

/* unit rng: hashes and random numbers, the same on every machine */

/* Returns a hash by the output function of O'Neill's PCG: Jarzynski and Olano, "Hash functions for GPU
   rendering", JCGT 9(3), 2020. */
static inline uint32_t envsh__hash32(uint32_t x)
{
    uint32_t state = x * 747796405u + 2891336453u;
    uint32_t word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

static inline uint32_t envsh__hash_combine(uint32_t a, uint32_t b)
{
    return envsh__hash32(a + 0x9e3779b9u * envsh__hash32(b));
}

/* Returns the upper 24 bits as a number in [0, 1). Every such value is a float; the largest is 1 - 2^-24. */
static inline float envsh__to_unit(uint32_t bits) { return (float)(bits >> 8) * (1.0f / 16777216.0f); }

/* ==== src/shared/batch.h ==== */

/* unit batch: tasks of a call, some at a time */

typedef struct envsh__batch { void (*task)(void *context, size_t index); void *context; size_t first; } envsh__batch;

/* The task of a batch, with the batch as its context. */
static inline void envsh__batch_task(void *context, size_t index)
{
    const envsh__batch *b = (const envsh__batch *)context;
    b->task(b->context, b->first + index);
}

/* ==== src/shared/raster.h ==== */

/* unit raster: the fill rule of rasterisers: triangles that share an edge leave no gap and do not overlap */

/* Returns 1 if points on an edge belong to the triangle whose edge this is, of the two that share it. The
   triangle lies on the side where dx (y - y0) - dy (x - x0) is positive; its left edges own their points,
   and its top edges if y grows downwards. Exactly one of two opposite edges owns. */
static inline int envsh__edge_owns(double dx, double dy) { return dy < 0.0 || (dy <= 0.0 && dx > 0.0); }

/* ==== src/shared/mask.h ==== */

/* unit mask: holes of alpha masks, asked for at the samples of rasters */

/* Writes the weights of a triangle's corners where the ray through x, y meets the triangle. c holds x, y and
   w of each corner as the view has them; w is the depth in units of the view's half width, and 1 where rays
   are parallel. A sample that rounding puts beyond an edge is moved onto the edge. */
static inline void envsh__mask_weights(const double *c, double x, double y, float weights[3])
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

/* ==== src/envshadow/errors.h ==== */

/* ---- errors: results and what is logged of them ---- */

ENVSH_DEF const char *envsh_result_text(envsh_result result)
{
    static const char *const texts[] = {
#define ENVSH__TEXT(name, text) text,
        ENVSH_RESULTS(ENVSH__TEXT)
#undef ENVSH__TEXT
    };
    return (unsigned)result < ENVSH_RESULT_COUNT ? texts[result] : "unknown result";
}

static envsh__logger envsh__make_logger(const envsh_system *system, const char *function)
{
    envsh__logger logger;
    logger.log = system->log;
    logger.user = system->user;
    logger.function = function;
    return logger;
}

/* Logs that a field has a value which is out of its range, and returns the result. */
static envsh_result envsh__refuse(const envsh__logger *logger, const char *field, double value,
                                  const char *wanted, envsh_result result)
{
    envsh__log_value(logger, field, value, wanted);
    return result;
}

/* Logs that there is no map of a light. */
static envsh_result envsh__refuse_light(const envsh__logger *logger, uint32_t light, uint32_t count)
{
    envsh__log_bound(logger, "light", light, "below", count, "the count of the last begin");
    return ENVSH_ERR_ARGUMENT;
}

/* Logs that a field is what the text says, as in "mesh is NULL", and returns the result. */
static envsh_result envsh__refuse_text(const envsh__logger *logger, const char *field, const char *text,
                                       envsh_result result)
{
    envsh__log_text(logger, field, text);
    return result;
}

static envsh_result envsh__refuse_no_depth(const envsh__logger *logger)
{
    return envsh__refuse_text(logger, "maps", "were made with desc.no_depth: they have no texels",
                              ENVSH_ERR_MISMATCH);
}

/* Returns whether elements of three floats may lie so many bytes apart; 0 says that they are packed. */
static int envsh__stride_fits(size_t stride) { return stride == 0 || (stride >= 12 && stride % 4 == 0); }

/* Logs that a stride of elements of three floats is out of range, and returns the result. */
static envsh_result envsh__refuse_stride(const envsh__logger *logger, const char *field, size_t stride)
{
    return envsh__refuse(logger, field, (double)stride, "0, or a multiple of 4 from 12 on",
                         ENVSH_ERR_ARGUMENT);
}

/* Returns element i of an array of three floats each. */
static envsh__v3 envsh__load_item(const float *base, size_t stride, size_t i)
{
    return envsh__v3_load((const float *)(const void *)((const char *)base + i * (stride ? stride : 12)));
}

/* Returns whether the vector counts as unit: lengths from 0.97 to 1.03 do, since normals of 8 bits a channel
   have such lengths. */
static int envsh__is_unit(envsh__v3 v)
{
    return envsh__is_unit2(envsh__v3_dot(v, v));
}

/* ==== src/envshadow/maps.h ==== */

/* ---- maps: the atlas and its views ---- */

#define ENVSH__CELL 8u              /* texels a side of a cell, whose least and greatest depth are kept */
#define ENVSH__NOTHING 1.0f         /* the depth of a texel without a caster */

struct envsh_maps {
    envsh__allocator allocator;
    envsh_system system;
    float        told, span;        /* the next steps go from the fraction told to told + span */
    uint32_t     map_side, guard, capacity, channels;
    uint32_t     across, down, pages;   /* tiles side by side, rows of tiles on a page, pages */
    uint32_t     cells;             /* cells a side of a tile */
    int          no_depth;
    envsh_rows       rows;
    envsh_clip_depth clip_depth;
    int          phase;             /* 0: no frame was begun; 1: it is being drawn; 2: it can be shaded with
                                       */
    uint32_t     count;             /* lights of the last envsh_maps_begin */
    envsh_view  *views;
    float       *depth;
    float       *bounds;            /* least and greatest depth of each cell, cells x cells x 2 a tile */
    size_t       bytes;             /* of all memory of the maps */
};

/* Runs count tasks, by the caller's parallel_for if there is one. */
static void envsh__for_each(const envsh_system *s, size_t count, envsh_task task, void *context)
{
    size_t i;
    if (s->parallel_for && count > 1) s->parallel_for(s->user, count, task, context);
    else
        for (i = 0; i < count; i++) task(context, i);
}

/* Tells the caller's progress that `part` of the next steps is done, and returns whether the caller cancels.
   */
static int envsh__tell_progress(const envsh_maps *m, float part)
{
    return m->system.progress && m->system.progress(m->system.user, m->told + m->span * part) != 0;
}

/* Runs count tasks in 16 steps, between which the caller may cancel; in one step if there is no progress. */
static envsh_result envsh__run_steps(const envsh_maps *m, size_t count, envsh_task task, void *context)
{
    size_t step, steps = m->system.progress ? 16 : 1;
    envsh__batch batch;
    batch.task = task;
    batch.context = context;
    batch.first = 0;
    for (step = 0; step < steps; step++) {
        size_t next = count / steps * (step + 1) + count % steps * (step + 1) / steps;
        if (envsh__tell_progress(m, (float)step / (float)steps)) return ENVSH_ERR_CANCELLED;
        envsh__for_each(&m->system, next - batch.first, envsh__batch_task, &batch);
        batch.first = next;
    }
    return envsh__tell_progress(m, 1.0f) ? ENVSH_ERR_CANCELLED : ENVSH_OK;
}

/* Fills in the defaults of a desc, and checks its fields. */
static envsh_result envsh__check_maps_desc(envsh_maps_desc *d, const envsh__logger *log)
{
    const envsh_result bad = ENVSH_ERR_DESC;
    if (!d->map_side) d->map_side = 256;
    if (!d->guard) d->guard = 4;
    if (!d->max_side) d->max_side = d->map_side > 8192 ? d->map_side : 8192;
    if (d->map_side < 16 || d->map_side > 4096)
        return envsh__refuse(log, "desc.map_side", d->map_side, "0 (= 256) or 16..4096", bad);
    if (d->guard > d->map_side / 4)
        return envsh__refuse(log, "desc.guard", d->guard, "0 (= 4) or 1..map_side / 4", bad);
    if (d->max_side < d->map_side || d->max_side > 32768)
        return envsh__refuse(log, "desc.max_side", d->max_side, "0 (= 8192) or map_side..32768", bad);
    if ((unsigned)d->rows >= ENVSH_ROWS_COUNT)
        return envsh__refuse(log, "desc.rows", d->rows, "one of envsh_rows", bad);
    if ((unsigned)d->clip_depth >= ENVSH_CLIP_DEPTH_COUNT)
        return envsh__refuse(log, "desc.clip_depth", d->clip_depth, "one of envsh_clip_depth", bad);
    if (!envsh__allocator_valid(d->system.allocator.alloc_fn, d->system.allocator.free_fn))
        return envsh__refuse_text(log, "desc.system.allocator", "has one of its two functions", bad);
    return ENVSH_OK;
}

/* Lays tiles out side by side on pages that are as square as may be and at most max_side wide and high. */
static void envsh__lay_out_tiles(envsh_maps *m, uint32_t max_side)
{
    uint32_t slots = (m->capacity + m->channels - 1) / m->channels, most = max_side / m->map_side, side = 1;
    while (side < most && side * side < slots) side++;
    m->across = slots < side ? slots : side;
    m->down = m->across ? (slots + m->across - 1) / m->across : 0;
    m->down = m->down < most ? m->down : most;
    m->pages = m->across ? (slots + m->across * m->down - 1) / (m->across * m->down) : 0;
}

ENVSH_DEF envsh_result envsh_maps_create(const envsh_maps_desc *desc, uint32_t capacity, envsh_maps **out)
{
    const envsh_allocator *own;
    envsh__allocator a;
    envsh__logger logger;
    envsh_maps_desc d;
    envsh_maps *m;
    envsh_result result;
    size_t texels = 0, cells = 0;
    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    logger = envsh__make_logger(&d.system, "envsh_maps_create");
    if (!out) return envsh__refuse_text(&logger, "out", "is NULL", ENVSH_ERR_ARGUMENT);
    if (capacity > ENVSH_MAX_LIGHTS)
        return envsh__refuse(&logger, "capacity", capacity, "0..8192", ENVSH_ERR_ARGUMENT);
    result = envsh__check_maps_desc(&d, &logger);
    if (result != ENVSH_OK) return result;
    own = &d.system.allocator;
    a = envsh__allocator_make(own->alloc_fn, own->free_fn, own->user);
    m = (envsh_maps *)envsh__alloc(&a, sizeof *m);
    if (!m) return envsh__refuse_text(&logger, "system.allocator", "returned no memory", ENVSH_ERR_ALLOC);
    memset(m, 0, sizeof *m);
    m->allocator = a;
    m->system = d.system;
    m->span = 1.0f;
    m->map_side = d.map_side;
    m->guard = d.guard;
    m->capacity = capacity;
    m->channels = d.rgba ? 4 : 1;
    m->no_depth = d.no_depth;
    m->rows = d.rows;
    m->clip_depth = d.clip_depth;
    m->cells = (d.map_side + ENVSH__CELL - 1) / ENVSH__CELL;
    envsh__lay_out_tiles(m, d.max_side);
    if (!envsh__mul_size((size_t)m->across * m->map_side, (size_t)m->down * m->map_side, &texels) ||
        !envsh__mul_size(texels, (size_t)m->pages * m->channels, &texels) || texels > SIZE_MAX / 16)
        result = envsh__refuse(&logger, "capacity", capacity, "less: size_t cannot count the texels",
                               ENVSH_ERR_LIMIT);
    cells = (size_t)m->cells * m->cells * 2 * capacity;
    if (result == ENVSH_OK && capacity) {
        m->views = (envsh_view *)envsh__alloc_array(&a, capacity, sizeof *m->views);
        if (!m->no_depth) m->depth = (float *)envsh__alloc_array(&a, texels, sizeof *m->depth);
        if (!m->no_depth) m->bounds = (float *)envsh__alloc_array(&a, cells, sizeof *m->bounds);
        if (!m->views || (!m->no_depth && (!m->depth || !m->bounds)))
            result = envsh__refuse_text(&logger, "system.allocator", "returned no memory", ENVSH_ERR_ALLOC);
    }
    m->bytes = sizeof *m + capacity * sizeof *m->views + (m->no_depth ? 0 : 4 * (texels + cells));
    if (result != ENVSH_OK) {
        envsh_maps_free(m);
        return result;
    }
    for (cells = 0; m->depth && cells < texels; cells++) m->depth[cells] = ENVSH__NOTHING;
    *out = m;
    return ENVSH_OK;
}

ENVSH_DEF void envsh_maps_free(envsh_maps *m)
{
    envsh__allocator a;
    if (!m) return;
    a = m->allocator;
    envsh__free(&a, m->bounds);
    envsh__free(&a, m->depth);
    envsh__free(&a, m->views);
    envsh__free(&a, m);
}

ENVSH_DEF void envsh_get_info(const envsh_maps *m, envsh_info *out)
{
    if (!m || !out) return;
    out->width = m->across * m->map_side;
    out->height = m->down * m->map_side;
    out->page_count = m->pages;
    out->channel_count = m->channels;
    out->map_side = m->map_side;
    out->guard = m->guard;
    out->capacity = m->capacity;
    out->depth = m->depth;
    out->bytes = m->bytes;
}

ENVSH_DEF const envsh_view *envsh_views(const envsh_maps *m, uint32_t *count)
{
    if (count) *count = m ? m->count : 0;
    return m ? m->views : NULL;
}

/* Returns the corner texel of a light's tile, and writes how many floats lie from one row to the next. The
   texels of a row lie m->channels floats apart. */
static float *envsh__tile_texels(const envsh_maps *m, uint32_t i, size_t *row)
{
    const envsh_view *v = &m->views[i];
    *row = (size_t)m->across * m->map_side * m->channels;
    return m->depth + ((size_t)v->page * m->down * m->map_side + v->y) * *row + (size_t)v->x * m->channels +
           v->channel;
}

/* ==== src/envshadow/fit.h ==== */

/* ---- fit: a light's map round the casters ---- */

typedef struct envsh__light { envsh__v3 direction, irradiance, axis_u, axis_v; } envsh__light;

/* Returns light i of the caller's arrays; a light without extent gets axes of length 0. */
static envsh__light envsh__light_at(const envsh_lights *lights, uint32_t i)
{
    envsh__light l;
    l.direction = envsh__load_item(lights->directions, lights->stride, i);
    l.irradiance = envsh__load_item(lights->irradiances, lights->stride, i);
    l.axis_u = l.axis_v = envsh__v3_make(0, 0, 0);
    if (!lights->axes_u) return l;
    l.axis_u = envsh__load_item(lights->axes_u, lights->stride, i);
    l.axis_v = envsh__load_item(lights->axes_v, lights->stride, i);
    return l;
}

/* Returns x rounded up to a sixteenth of an octave: a texel keeps its size while bounds change a little.
   The four upper bits of the mantissa stay. */
static float envsh__round_up_texel(float x)
{
    uint32_t bits = envsh__to_bits(x), low = bits & 0x7ffffu;
    return envsh__from_bits(low ? bits - low + 0x80000u : bits);
}

/* Writes a row of envsh_view.lookup, which gives the texel's x, its y or the depth for a point of the world.
   */
static void envsh__set_row(float *row, envsh__v3 axis, float scale, float offset)
{
    envsh__v3_store(row, envsh__v3_scale(axis, scale));
    row[3] = offset;
}

/* Writes the matrix from the world to clip space: texels 0..map_side become -1..1, depth 0..1 becomes what
   clip_depth says. */
static void envsh__clip_matrix(const envsh_maps *m, envsh_view *v)
{
    float s = 2.0f / (float)m->map_side, flip = m->rows == ENVSH_ROWS_TOP_FIRST ? -1.0f : 1.0f;
    float z = 2.0f, less = 1.0f;
    int c;
    if (m->clip_depth == ENVSH_CLIP_DEPTH_ZERO_TO_ONE) z = 1.0f, less = 0.0f;
    if (m->clip_depth == ENVSH_CLIP_DEPTH_REVERSED) z = -1.0f, less = -1.0f;
    for (c = 0; c < 4; c++) {
        v->world_to_clip[4 * c] = v->lookup[c] * s - (c == 3 ? 1.0f : 0.0f);
        v->world_to_clip[4 * c + 1] = flip * (v->lookup[4 + c] * s - (c == 3 ? 1.0f : 0.0f));
        v->world_to_clip[4 * c + 2] = v->lookup[8 + c] * z - (c == 3 ? less : 0.0f);
        v->world_to_clip[4 * c + 3] = c == 3 ? 1.0f : 0.0f;
    }
}

/* Fits a light's tile to the bounds: two axes across the light and one along it, the size of a texel, and the
   range of depths. */
static void envsh__fit_view(const envsh_maps *m, const envsh__light *l, const envsh_bounds *b, envsh_view *v)
{
    envsh__v3 axis[3];
    float low[3], high[3];
    float inner = (float)(m->map_side - 2 * m->guard) - 1.0f;
    float diagonal = 0.0f;
    float range, margin;
    int i, j;
    axis[2] = envsh__v3_normalize(l->direction);
    envsh__v3_basis(axis[2], &axis[0], &axis[1]);
    axis[2] = envsh__v3_scale(axis[2], -1.0f);      /* since depth grows away from the light */
    for (i = 0; i < 3; i++) {
        float d[3];
        envsh__v3_store(d, axis[i]);
        low[i] = high[i] = 0.0f;
        for (j = 0; j < 3; j++) {
            float a = d[j] * b->low[j], c = d[j] * b->high[j];
            low[i] += a < c ? a : c;
            high[i] += a < c ? c : a;
        }
        diagonal += (b->high[i] - b->low[i]) * (b->high[i] - b->low[i]);
    }
    diagonal = sqrtf(diagonal);
    for (i = 0; i < 2; i++) {
        float size = high[i] - low[i], texel, corner;
        size = size > 1e-4f * diagonal ? size : 1e-4f * diagonal;
        texel = envsh__round_up_texel(size / inner);
        corner = floorf((0.5f * (low[i] + high[i]) - 0.5f * texel * (inner + 1.0f)) / texel + 0.5f);
        v->texel[i] = texel;
        envsh__set_row(v->lookup + 4 * i, axis[i], 1.0f / texel, (float)m->guard - corner);
    }
    margin = 1e-3f * diagonal + 1e-6f * (fabsf(low[2]) + fabsf(high[2]));
    range = high[2] - low[2] + 2.0f * margin;
    v->depth_range = range;
    envsh__set_row(v->lookup + 8, axis[2], 1.0f / range, (margin - low[2]) / range);
    envsh__v3_store(v->right, axis[0]);
    envsh__v3_store(v->up, axis[1]);
    for (i = 0; i < 2; i++) {
        v->spread[i] = envsh__v3_dot(axis[i], l->axis_u) * range / v->texel[i];
        v->spread[2 + i] = envsh__v3_dot(axis[i], l->axis_v) * range / v->texel[i];
    }
}

/* Checks one light of the caller's arrays. */
static envsh_result envsh__check_light(const envsh_lights *lights, uint32_t i, const envsh__logger *log)
{
    envsh__light l = envsh__light_at(lights, i);
    float length = envsh__v3_length(l.direction), most = envsh__v3_length(l.axis_u);
    float other = envsh__v3_length(l.axis_v);
    if (!envsh__is_unit(l.direction)) {
        envsh__log_element(log, "lights.directions", i, "has the length", (double)length, "1 (0.97..1.03)");
        return ENVSH_ERR_INPUT;
    }
    if (!(fabsf(l.irradiance.x) <= 1e32f && fabsf(l.irradiance.y) <= 1e32f &&
          fabsf(l.irradiance.z) <= 1e32f)) {
        envsh__log_element(log, "lights.irradiances", i, "begins with", (double)l.irradiance.x,
                           "-1e32..1e32, all three");
        return ENVSH_ERR_INPUT;
    }
    if (most < 1e3f && other < 1e3f) return ENVSH_OK;
    envsh__log_element(log, most < 1e3f ? "lights.axes_v" : "lights.axes_u", i, "has the length",
                       (double)(most < 1e3f ? other : most), "below 1000");
    return ENVSH_ERR_INPUT;
}

/* Checks the arrays of lights and each light, but not whether the maps hold so many. */
static envsh_result envsh__check_lights(const envsh_lights *lights, const envsh__logger *log)
{
    const envsh_result bad = ENVSH_ERR_ARGUMENT;
    envsh_result result = ENVSH_OK;
    uint32_t i;
    if (!lights->count) return ENVSH_OK;
    if (!lights->directions) return envsh__refuse_text(log, "lights.directions", "is NULL", bad);
    if (!lights->irradiances) return envsh__refuse_text(log, "lights.irradiances", "is NULL", bad);
    if (!lights->axes_u != !lights->axes_v)
        return envsh__refuse_text(log, lights->axes_u ? "lights.axes_v" : "lights.axes_u",
                                  "is NULL, and the other axes are not", bad);
    if (!envsh__stride_fits(lights->stride))
        return envsh__refuse_stride(log, "lights.stride", lights->stride);
    for (i = 0; i < lights->count && result == ENVSH_OK; i++) result = envsh__check_light(lights, i, log);
    return result;
}

/* Checks bounds. If they are empty or a point, they become a box in which nothing is divided by 0. */
static envsh_result envsh__check_bounds(envsh_bounds *b, const envsh__logger *log)
{
    int c, empty = 0;
    float size = 0.0f;
    for (c = 0; c < 3; c++) {
        if (!(fabsf(b->low[c]) <= 1e15f))
            return envsh__refuse(log, "bounds.low", (double)b->low[c], "-1e15..1e15", ENVSH_ERR_INPUT);
        if (!(fabsf(b->high[c]) <= 1e15f))
            return envsh__refuse(log, "bounds.high", (double)b->high[c], "-1e15..1e15", ENVSH_ERR_INPUT);
        empty |= b->low[c] > b->high[c];
        if (b->high[c] - b->low[c] > size) size = b->high[c] - b->low[c];
    }
    for (c = 0; c < 3 && (empty || !(size > 1e-15f)); c++) {      /* any box about the point will do */
        float middle = empty ? 0.0f : b->low[c], half = 0.5f + 1e-3f * fabsf(middle);
        b->low[c] = middle - half;
        b->high[c] = middle + half;
    }
    return ENVSH_OK;
}

/* Clears the tile of light i. */
static void envsh__clear_task(void *context, size_t i)
{
    envsh_maps *m = (envsh_maps *)context;
    size_t row, x, y;
    float *tile = envsh__tile_texels(m, (uint32_t)i, &row);
    for (y = 0; y < m->map_side; y++)
        for (x = 0; x < m->map_side; x++) tile[y * row + x * m->channels] = ENVSH__NOTHING;
}

ENVSH_DEF envsh_result envsh_maps_begin(envsh_maps *m, const envsh_lights *lights, envsh_bounds bounds)
{
    uint32_t i, count = lights ? lights->count : 0;
    envsh__logger logger;
    envsh_result result = ENVSH_OK;
    if (!m) return ENVSH_ERR_ARGUMENT;
    logger = envsh__make_logger(&m->system, "envsh_maps_begin");
    if (count > m->capacity) {
        envsh__log_bound(&logger, "lights.count", count, "at most", m->capacity, "the capacity of the maps");
        return ENVSH_ERR_LIMIT;
    }
    if (lights) result = envsh__check_lights(lights, &logger);
    if (result == ENVSH_OK) result = envsh__check_bounds(&bounds, &logger);
    if (result != ENVSH_OK) return result;
    for (i = 0; i < count; i++) {
        envsh_view *v = &m->views[i];
        envsh__light l = envsh__light_at(lights, i);
        uint32_t slot = i / m->channels;
        memset(v, 0, sizeof *v);
        v->channel = i % m->channels;
        v->x = slot % m->across * m->map_side;
        v->y = slot / m->across % m->down * m->map_side;
        v->page = slot / (m->across * m->down);
        v->guard = m->guard;
        envsh__v3_store(v->direction, l.direction);
        envsh__v3_store(v->irradiance, l.irradiance);
        envsh__fit_view(m, &l, &bounds, v);
        envsh__clip_matrix(m, v);
    }
    m->count = count;
    m->phase = 1;
    if (!m->no_depth) envsh__for_each(&m->system, count, envsh__clear_task, m);
    return ENVSH_OK;
}

/* ==== src/envshadow/raster.h ==== */

/* ---- raster: depth of triangles, without a GPU ---- */

/* A corner of a triangle in a tile: x and y in 256ths of a texel, and its depth. */
typedef struct envsh__corner3 { int64_t x, y; float z; } envsh__corner3;

/* Returns what is added to the edge function so that 0 or more means inside: 0 if this triangle owns the
   points on the edge, -1 if its neighbour does. */
static int64_t envsh__edge_bias(const envsh__corner3 *a, const envsh__corner3 *b)
{
    return envsh__edge_owns((double)(b->x - a->x), (double)(b->y - a->y)) ? 0 : -1;
}

/* Returns the edge function of a to b at (x, y), which is above 0 on the left of the edge. */
static int64_t envsh__edge_value(const envsh__corner3 *a, const envsh__corner3 *b, int64_t x, int64_t y)
{
    return (b->x - a->x) * (y - a->y) - (b->y - a->y) * (x - a->x);
}

typedef struct envsh__tile_target { /* the tile that is drawn into */
    float  *tile;                   /* its corner texel */
    size_t  row, step;              /* floats from one row to the next, and from one texel to the next */
    int64_t low, high;              /* the first and the last texel, both ways, that is not guard */
} envsh__tile_target;

/* The texels whose centres may lie in a triangle: columns x0..x1 and rows y0..y1, ends included. */
typedef struct envsh__texel_box { int64_t x0, y0, x1, y1; } envsh__texel_box;

/* Returns the texels of the tile whose centres lie in the box about three corners. If there are none, x0 > x1
   or y0 > y1. */
static envsh__texel_box envsh__bound_texels(const envsh__tile_target *to, const envsh__corner3 *p,
                                            const envsh__corner3 *q, const envsh__corner3 *r)
{
    envsh__texel_box box;
    int64_t x0 = p->x < q->x ? p->x : q->x;
    int64_t x1 = p->x < q->x ? q->x : p->x;
    int64_t y0 = p->y < q->y ? p->y : q->y;
    int64_t y1 = p->y < q->y ? q->y : p->y;
    x0 = ((r->x < x0 ? r->x : x0) + 127) >> 8;       /* the first texel whose centre is not left of the box */
    x1 = ((r->x > x1 ? r->x : x1) - 128) >> 8;
    y0 = ((r->y < y0 ? r->y : y0) + 127) >> 8;
    y1 = ((r->y > y1 ? r->y : y1) - 128) >> 8;
    box.x0 = x0 < to->low ? to->low : x0;
    box.y0 = y0 < to->low ? to->low : y0;
    box.x1 = x1 > to->high ? to->high : x1;
    box.y1 = y1 > to->high ? to->high : y1;
    return box;
}

/* The mask of the triangle that is drawn: its corners are x, y in texels, and 1. */
typedef struct envsh__mask {
    const envsh_mesh *mesh;
    uint32_t          triangle;
    double            corners[9];
} envsh__mask;

/* Returns whether the mask has a hole at the centre of texel x, y. */
static int envsh__is_hole(const envsh__mask *mask, int64_t x, int64_t y)
{
    float weights[3];
    envsh__mask_weights(mask->corners, (double)x + 0.5, (double)y + 0.5, weights);
    return !mask->mesh->mask_fn(mask->mesh->user, mask->triangle, weights);
}

/* Draws the depth of a triangle into the texels of the tile that it covers. mask: NULL = none */
static void envsh__raster_triangle(const envsh__tile_target *to, const envsh__mask *mask,
                                   const envsh__corner3 *p, const envsh__corner3 *q, const envsh__corner3 *r)
{
    const envsh__corner3 *swap;
    envsh__texel_box box;
    int64_t area = envsh__edge_value(p, q, r->x, r->y);
    int64_t x, y;
    int64_t e0, e1, e2;
    int64_t b0, b1, b2;
    float zx, zy, z0;
    float lo, hi;
    double inv;
    if (area == 0) return;
    if (area < 0) {
        swap = q;
        q = r;
        r = swap;
        area = -area;
    }
    box = envsh__bound_texels(to, p, q, r);
    if (box.x0 > box.x1 || box.y0 > box.y1) return;
    /* Depth is a plane over the texels: zx and zy are its slopes. It is kept within lo..hi, the triangle's
       own range, since rounding would lead beyond where triangles are thin. */
    inv = 256.0 / (double)area;
    zx = (float)(((double)(q->z - p->z) * (double)(r->y - p->y) -
                  (double)(r->z - p->z) * (double)(q->y - p->y)) * inv);
    zy = (float)(((double)(r->z - p->z) * (double)(q->x - p->x) -
                  (double)(q->z - p->z) * (double)(r->x - p->x)) * inv);
    lo = p->z < q->z ? p->z : q->z;
    hi = p->z < q->z ? q->z : p->z;
    lo = r->z < lo ? r->z : lo;
    hi = r->z > hi ? r->z : hi;
    lo = lo < 0.0f ? 0.0f : lo;             /* what is nearer than the near plane is in the way all the same
                                               */
    z0 = p->z + zx * ((float)(box.x0 * 256 + 128 - p->x) / 256.0f) +
         zy * ((float)(box.y0 * 256 + 128 - p->y) / 256.0f);
    b0 = envsh__edge_value(p, q, box.x0 * 256 + 128, box.y0 * 256 + 128) + envsh__edge_bias(p, q);
    b1 = envsh__edge_value(q, r, box.x0 * 256 + 128, box.y0 * 256 + 128) + envsh__edge_bias(q, r);
    b2 = envsh__edge_value(r, p, box.x0 * 256 + 128, box.y0 * 256 + 128) + envsh__edge_bias(r, p);
    for (y = box.y0; y <= box.y1; y++) {
        float *out = to->tile + (size_t)y * to->row + (size_t)box.x0 * to->step;
        float zr = z0 + zy * (float)(y - box.y0);
        e0 = b0;
        e1 = b1;
        e2 = b2;
        for (x = box.x0; x <= box.x1; x++, out += to->step) {
            if ((e0 | e1 | e2) >= 0) {
                float z = zr + zx * (float)(x - box.x0);
                z = z < lo ? lo : z > hi ? hi : z;
                if (z < *out && !(mask && envsh__is_hole(mask, x, y))) *out = z;
            }
            e0 -= (q->y - p->y) * 256;
            e1 -= (r->y - q->y) * 256;
            e2 -= (p->y - r->y) * 256;
        }
        b0 += (q->x - p->x) * 256;
        b1 += (r->x - q->x) * 256;
        b2 += (p->x - r->x) * 256;
    }
}

/* Multiplies a row of the lookup by the mesh's transform. */
static void envsh__combine_row(const float *row, const float *m, float *out)
{
    int c;
    for (c = 0; c < 4; c++) {
        out[c] = row[0] * m[4 * c] + row[1] * m[4 * c + 1] + row[2] * m[4 * c + 2];
        if (c == 3) out[c] += row[3];
    }
}

/* Triangles whose corners lie within this many texels of the tile's corner are drawn as they are. Others are
   cut to that reach first, in doubles: floats are too coarse there for 256ths of a texel and for depths. */
#define ENVSH__REACH 32768.0

/* Writes where a corner lies in the tile. Returns 0 if the corner is beyond reach or not finite, in which
   case envsh__cut_triangle decides about the triangle. */
static int envsh__transform_corner(const float *rows, const float *p, envsh__corner3 *out)
{
    const float limit = (float)ENVSH__REACH;
    float x = rows[0] * p[0] + rows[1] * p[1] + rows[2] * p[2] + rows[3];
    float y = rows[4] * p[0] + rows[5] * p[1] + rows[6] * p[2] + rows[7];
    float z = rows[8] * p[0] + rows[9] * p[1] + rows[10] * p[2] + rows[11];
    if (!(fabsf(x) <= limit && fabsf(y) <= limit) || !envsh__finite(z)) return 0;
    out->x = (int64_t)floorf(x * 256.0f + 0.5f);
    out->y = (int64_t)floorf(y * 256.0f + 0.5f);
    out->z = z;
    return 1;
}

/* A point in a tile, in doubles: x and y in texels, and the depth. */
typedef struct envsh__point64 { double p[3]; } envsh__point64;

/* Returns the point where an edge crosses the limit of reach. `in` is its end within reach and `out` its
   other end, din and dout their distances from the limit. The point is computed from the inner end whichever
   way the edge runs, so that both triangles at the edge get the same point. */
static envsh__point64 envsh__cross_reach(const envsh__point64 *in, const envsh__point64 *out, double din,
                                         double dout)
{
    envsh__point64 c;
    int i;
    for (i = 0; i < 3; i++) c.p[i] = in->p[i] + (out->p[i] - in->p[i]) * (din / (din - dout));
    return c;
}

/* Cuts a polygon to the square of what is within reach (Sutherland and Hodgman 1974), and returns how many
   corners are left. q has room for 8 points. */
static int envsh__cut_to_reach(envsh__point64 *q, int count)
{
    envsh__point64 r[8];
    int side, i, n;
    for (side = 0; side < 4 && count > 2; side++) {
        double sign = side & 1 ? -1.0 : 1.0;
        for (i = 0, n = 0; i < count; i++) {
            const envsh__point64 *a = q + i, *b = q + (i + 1 == count ? 0 : i + 1);
            double da = ENVSH__REACH - sign * a->p[side >> 1], db = ENVSH__REACH - sign * b->p[side >> 1];
            if (da >= 0.0) r[n++] = *a;
            if (da >= 0.0 && db < 0.0) r[n++] = envsh__cross_reach(a, b, da, db);
            if (da < 0.0 && db >= 0.0) r[n++] = envsh__cross_reach(b, a, db, da);
        }
        count = n;
        memcpy(q, r, (size_t)n * sizeof *r);
    }
    return count;
}

/* Cuts a triangle to what is within reach, and returns how many corners are left, which is 0 if a corner lies
   where no float does. c has room for 8 corners. */
static int envsh__cut_triangle(const float *rows, const float *const *corners, envsh__corner3 *c)
{
    envsh__point64 q[8];
    int i, k, n;
    for (i = 0; i < 3; i++)
        for (k = 0; k < 3; k++) {
            const float *row = rows + 4 * k, *p = corners[i];
            q[i].p[k] = (double)row[0] * (double)p[0] + (double)row[1] * (double)p[1] +
                        (double)row[2] * (double)p[2] + (double)row[3];
            if (!(fabs(q[i].p[k]) <= 3e38)) return 0;
        }
    n = envsh__cut_to_reach(q, 3);
    for (i = 0; i < n; i++) {
        c[i].x = (int64_t)floor(q[i].p[0] * 256.0 + 0.5);
        c[i].y = (int64_t)floor(q[i].p[1] * 256.0 + 0.5);
        c[i].z = (float)q[i].p[2];
    }
    return n;
}

/* ==== src/envshadow/draw.h ==== */

/* ---- draw: meshes and foreign depths into the tiles ---- */

typedef struct envsh__draw {
    envsh_maps *maps;
    const envsh_mesh *mesh;
    const float *transform;
    size_t triangles, stride;
} envsh__draw;

/* Returns the number of the vertex at corner i of the mesh, three corners to a triangle. */
static size_t envsh__index_at(const envsh_mesh *mesh, size_t i)
{
    return mesh->indices ? mesh->indices[i] : mesh->indices16 ? mesh->indices16[i] : i;
}

/* Writes where the corners of a triangle lie in the tile, for its mask. */
static void envsh__place_mask(const float *rows, const float *const *corners, envsh__mask *mask)
{
    int i, k;
    for (i = 0; i < 3; i++) {
        for (k = 0; k < 2; k++) {
            const float *row = rows + 4 * k, *p = corners[i];
            mask->corners[3 * i + k] = (double)row[0] * (double)p[0] + (double)row[1] * (double)p[1] +
                                       (double)row[2] * (double)p[2] + (double)row[3];
        }
        mask->corners[3 * i + 2] = 1.0;
    }
}

/* Draws the mesh into the tile of light i. */
static void envsh__draw_task(void *context, size_t i)
{
    const envsh__draw *d = (const envsh__draw *)context;
    const envsh_maps *m = d->maps;
    const envsh_view *v = &m->views[i];
    const char *positions = (const char *)d->mesh->positions;
    envsh__tile_target to;
    envsh__mask mask;
    envsh__corner3 c[8];
    const float *p[3];
    float rows[12];
    size_t t, k;
    to.tile = envsh__tile_texels(m, (uint32_t)i, &to.row);
    to.step = m->channels;
    mask.mesh = d->mesh;
    to.low = (int64_t)m->guard;
    to.high = (int64_t)(m->map_side - m->guard) - 1;
    for (k = 0; k < 3; k++)
        if (d->transform) envsh__combine_row(v->lookup + 4 * k, d->transform, rows + 4 * k);
        else memcpy(rows + 4 * k, v->lookup + 4 * k, 4 * sizeof *rows);
    for (t = 0; t < d->triangles; t++) {
        int within = 1, n = 3, j;
        for (k = 0; k < 3; k++) {
            size_t index = envsh__index_at(d->mesh, 3 * t + k);
            p[k] = (const float *)(const void *)(positions + index * d->stride);
            within &= envsh__transform_corner(rows, p[k], &c[k]);
        }
        if (!within) n = envsh__cut_triangle(rows, p, c);
        if (d->mesh->mask_fn) envsh__place_mask(rows, p, &mask);
        mask.triangle = (uint32_t)t;
        for (j = 2; j < n; j++)
            envsh__raster_triangle(&to, d->mesh->mask_fn ? &mask : NULL, &c[0], &c[j - 1], &c[j]);
    }
}

/* Checks a mesh and writes how many triangles the mesh has. */
static envsh_result envsh__check_mesh(const envsh_mesh *mesh, size_t *triangles, const envsh__logger *log)
{
    const int indexed = mesh->indices || mesh->indices16;
    size_t i, n = indexed ? mesh->index_count : mesh->vertex_count;
    size_t stride = mesh->vertex_stride ? mesh->vertex_stride : 12;
    if (!mesh->positions && n)
        return envsh__refuse_text(log, "mesh.positions", "is NULL", ENVSH_ERR_ARGUMENT);
    if (!envsh__stride_fits(mesh->vertex_stride))
        return envsh__refuse_stride(log, "mesh.vertex_stride", mesh->vertex_stride);
    if (mesh->vertex_count && stride > SIZE_MAX / mesh->vertex_count)
        return envsh__refuse(log, "mesh.vertex_count", (double)mesh->vertex_count,
                             "less: the mesh has more bytes than there are addresses", ENVSH_ERR_LIMIT);
    if (mesh->indices && mesh->indices16)
        return envsh__refuse_text(log, "mesh.indices, mesh.indices16", "are both given", ENVSH_ERR_ARGUMENT);
    if (n % 3)
        return envsh__refuse(log, indexed ? "mesh.index_count" : "mesh.vertex_count", (double)n,
                             "a multiple of 3", ENVSH_ERR_ARGUMENT);
    for (i = 0; indexed && i < n; i++)
        if (envsh__index_at(mesh, i) >= mesh->vertex_count) {
            envsh__log_index(log, "mesh", i, envsh__index_at(mesh, i), mesh->vertex_count);
            return ENVSH_ERR_INPUT;
        }
    *triangles = n / 3;
    return ENVSH_OK;
}

/* Checks whether maps can be drawn into: they have texels, and a frame was begun. */
static envsh_result envsh__check_phase(const envsh_maps *m, const envsh__logger *log)
{
    if (m->no_depth) return envsh__refuse_no_depth(log);
    if (!m->phase) return envsh__refuse_text(log, "envsh_maps_begin", "must come first", ENVSH_ERR_ORDER);
    return ENVSH_OK;
}

ENVSH_DEF envsh_result envsh_maps_draw(envsh_maps *m, const envsh_mesh *mesh, const float transform[16])
{
    envsh__draw d;
    envsh__logger logger;
    envsh_result result;
    if (!m) return ENVSH_ERR_ARGUMENT;
    logger = envsh__make_logger(&m->system, "envsh_maps_draw");
    if (!mesh) return envsh__refuse_text(&logger, "mesh", "is NULL", ENVSH_ERR_ARGUMENT);
    if (transform && !envsh__m4_is_affine(transform))
        return envsh__refuse_text(&logger, "transform", "is not affine", ENVSH_ERR_INPUT);
    result = envsh__check_phase(m, &logger);
    if (result == ENVSH_OK) result = envsh__check_mesh(mesh, &d.triangles, &logger);
    if (result != ENVSH_OK) return result;
    d.maps = m;
    d.mesh = mesh;
    d.transform = transform;
    d.stride = mesh->vertex_stride ? mesh->vertex_stride : 12;
    m->phase = 1;
    return envsh__run_steps(m, m->count, envsh__draw_task, &d);
}

ENVSH_DEF envsh_result envsh_maps_set(envsh_maps *m, uint32_t light, const float *depth, size_t row_stride)
{
    size_t row, x, y, packed;
    size_t stride = row_stride;
    envsh__logger logger;
    envsh_result result;
    float *tile;
    if (!m) return ENVSH_ERR_ARGUMENT;
    logger = envsh__make_logger(&m->system, "envsh_maps_set");
    packed = (size_t)m->map_side * 4;
    if (!depth) return envsh__refuse_text(&logger, "depth", "is NULL", ENVSH_ERR_ARGUMENT);
    result = envsh__check_phase(m, &logger);
    if (result != ENVSH_OK) return result;
    if (light >= m->count) return envsh__refuse_light(&logger, light, m->count);
    if (!stride) stride = packed;
    if (stride < packed || stride % 4)
        return envsh__refuse(&logger, "row_stride", (double)stride,
                             "0, or a multiple of 4 from 4 map_side on", ENVSH_ERR_ARGUMENT);
    tile = envsh__tile_texels(m, light, &row);
    for (y = m->guard; y < m->map_side - m->guard; y++)
        for (x = m->guard; x < m->map_side - m->guard; x++) {
            float z = ((const float *)(const void *)((const char *)depth + y * stride))[x];
            if (m->clip_depth == ENVSH_CLIP_DEPTH_REVERSED) z = 1.0f - z;
            tile[y * row + x * m->channels] = z < ENVSH__NOTHING ? (z > 0.0f ? z : 0.0f) : ENVSH__NOTHING;
        }
    m->phase = 1;
    return ENVSH_OK;
}

ENVSH_DEF envsh_bounds envsh_bounds_of(const envsh_mesh *meshes, size_t count, const float *transforms)
{
    envsh_bounds b;
    size_t i, j;
    int c;
    for (c = 0; c < 3; c++) {
        b.low[c] = 1e15f;
        b.high[c] = -1e15f;
    }
    for (i = 0; meshes && i < count; i++) {
        size_t stride = meshes[i].vertex_stride ? meshes[i].vertex_stride : 12;
        for (j = 0; meshes[i].positions && j < meshes[i].vertex_count; j++) {
            envsh__v3 p = envsh__v3_load((const float *)(const void *)((const char *)meshes[i].positions +
                                                                       j * stride));
            float q[3];
            if (transforms) p = envsh__m4_point(transforms + 16 * i, p);
            envsh__v3_store(q, p);
            for (c = 0; c < 3 && envsh__v3_finite(p); c++) {
                float v = q[c] > 1e15f ? 1e15f : q[c] < -1e15f ? -1e15f : q[c];
                b.low[c] = v < b.low[c] ? v : b.low[c];
                b.high[c] = v > b.high[c] ? v : b.high[c];
            }
        }
    }
    return b;
}

/* Finds the least and greatest depth of each cell of tile i, by which most filters need no texel at all. */
static void envsh__bounds_task(void *context, size_t i)
{
    const envsh_maps *m = (const envsh_maps *)context;
    size_t row, x, y;
    float *tile, *out = m->bounds + 2 * i * m->cells * m->cells;
    tile = envsh__tile_texels(m, (uint32_t)i, &row);
    for (y = 0; y < (size_t)m->cells * m->cells; y++) {
        out[2 * y] = ENVSH__NOTHING;
        out[2 * y + 1] = 0.0f;
    }
    for (y = 0; y < m->map_side; y++)
        for (x = 0; x < m->map_side; x++) {
            float z = tile[y * row + x * m->channels];
            float *cell = out + 2 * (y / ENVSH__CELL * m->cells + x / ENVSH__CELL);
            if (z < cell[0]) cell[0] = z;
            if (z > cell[1]) cell[1] = z;
        }
}

ENVSH_DEF envsh_result envsh_maps_end(envsh_maps *m)
{
    envsh__logger logger;
    envsh_result result;
    if (!m) return ENVSH_ERR_ARGUMENT;
    logger = envsh__make_logger(&m->system, "envsh_maps_end");
    result = envsh__check_phase(m, &logger);
    if (result != ENVSH_OK) return result;
    envsh__for_each(&m->system, m->count, envsh__bounds_task, m);
    m->phase = 2;
    return ENVSH_OK;
}

/* ==== src/envshadow/filter.h ==== */

/* ---- filter: visibility of one light at one point ---- */

typedef struct envsh__lookup {
    const envsh_view *view;
    const float *tile;              /* the corner texel of the light's tile */
    const float *cells;             /* least and greatest depth of its cells; NULL: every texel is read */
    size_t   row, step;             /* floats from one row to the next, and from one texel to the next */
    int32_t  size, cells_wide;      /* texels and cells a side */
    const envsh_query *query;       /* with its defaults filled in */
    uint32_t first;                 /* the number of the point with index 0 */
    const float *disc;              /* x and y of taps on the unit disc */
} envsh__lookup;

typedef struct envsh__receiver {
    float x, y, z;                  /* texels, and depth */
    float gx, gy;                   /* the slopes of its plane: depth over texels */
    float texel_depth;              /* the size of a texel as a depth */
    float limit;                    /* how much nearer to the light than the receiver a tap may be taken to
                                       lie */
} envsh__receiver;

/* Sets how far the receiver's plane is followed towards the light. The plane goes on through walls that stand
   on the receiver's surface, so that it is not followed farther than three texels and the radius of a fixed
   kernel. The penumbra's kernel needs less: what is taken for an occluder although it is the surface itself
   is near, and a near occluder makes the kernel small. */
static void envsh__set_limit(envsh__receiver *r, float radius)
{
    r->limit = (radius + 3.0f) * r->texel_depth;
}

/* Returns whether the receiver's plane is lit at the texel's centre. Beyond the tile nothing is in the way.
   */
static int envsh__is_lit(const envsh__lookup *l, const envsh__receiver *r, int32_t x, int32_t y)
{
    float stored, z;
    if (x < 0 || y < 0 || x >= l->size || y >= l->size) return 1;
    stored = l->tile[(size_t)y * l->row + (size_t)x * l->step];
    z = r->gx * ((float)x + 0.5f - r->x) + r->gy * ((float)y + 0.5f - r->y);
    z = r->z + (z < -r->limit ? -r->limit : z);
    return stored >= ENVSH__NOTHING || z <= stored;
}

/* Returns the texel that a coordinate lies in, at least -64 and at most 8192, which are beyond every tile. */
static int32_t envsh__texel_index(float x)
{
    return x < -64.0f ? -64 : x > 8192.0f ? 8192 : (int32_t)floorf(x);
}

/* Returns 1 if the cells say that all of a kernel of half widths rx, ry is lit, 0 if they say that all of it
   is in shadow, and -1 if they do not tell. */
static int envsh__decide_by_cells(const envsh__lookup *l, const envsh__receiver *r, float rx, float ry)
{
    float lo = ENVSH__NOTHING, hi = 0.0f, slope = fabsf(r->gx) * (rx + 1.0f) + fabsf(r->gy) * (ry + 1.0f);
    int32_t x0, x1, y0, y1;
    int32_t x, y;
    int32_t last = l->cells_wide - 1;
    int32_t edge = l->size - 1;
    int32_t outside;
    if (!l->cells) return -1;
    x0 = envsh__texel_index(r->x - rx);
    x1 = envsh__texel_index(r->x + rx);
    y0 = envsh__texel_index(r->y - ry);
    y1 = envsh__texel_index(r->y + ry);
    outside = x0 < 0 || y0 < 0 || x1 > edge || y1 > edge;
    if (x1 < 0 || y1 < 0 || x0 > edge || y0 > edge) return 1;
    x0 = x0 < 0 ? 0 : x0 / (int32_t)ENVSH__CELL;
    y0 = y0 < 0 ? 0 : y0 / (int32_t)ENVSH__CELL;
    x1 = x1 / (int32_t)ENVSH__CELL;
    y1 = y1 / (int32_t)ENVSH__CELL;
    x1 = x1 > last ? last : x1;
    y1 = y1 > last ? last : y1;
    for (y = y0; y <= y1; y++)
        for (x = x0; x <= x1; x++) {
            const float *cell = l->cells + 2 * ((size_t)y * (size_t)l->cells_wide + (size_t)x);
            lo = cell[0] < lo ? cell[0] : lo;
            hi = cell[1] > hi ? cell[1] : hi;
        }
    if (lo >= ENVSH__NOTHING || r->z + slope <= lo) return 1;
    slope = slope < r->limit ? slope : r->limit;
    return !outside && hi < ENVSH__NOTHING && r->z - slope > hi ? 0 : -1;
}

/* Returns the lit share of all texels whose centres are within radius + 1 along both axes, by weights that
   fall linearly to 0 there. */
static float envsh__filter_smooth(const envsh__lookup *l, const envsh__receiver *r)
{
    float radius = l->query->radius;
    float sum = 0.0f;
    float weights = 0.0f;
    float wx, wy;
    int32_t reach = (int32_t)radius + 1;
    int32_t cx = envsh__texel_index(r->x);
    int32_t cy = envsh__texel_index(r->y);
    int32_t x, y;
    for (y = cy - reach; y <= cy + reach; y++) {
        wy = radius + 1.0f - fabsf((float)y + 0.5f - r->y);
        if (!(wy > 0.0f)) continue;
        for (x = cx - reach; x <= cx + reach; x++) {
            wx = radius + 1.0f - fabsf((float)x + 0.5f - r->x);
            if (!(wx > 0.0f)) continue;
            weights += wx * wy;
            if (envsh__is_lit(l, r, x, y)) sum += wx * wy;
        }
    }
    return weights > 0.0f ? sum / weights : 1.0f;
}

/* Returns the share of taps that are lit on an ellipse of the half axes a and b, in texels. c and s are
   cosine and sine of the angle by which the taps are turned. */
static float envsh__filter_taps(const envsh__lookup *l, const envsh__receiver *r, const float *a,
                                const float *b, float c, float s)
{
    uint32_t i, n = l->query->tap_count, lit = 0;
    for (i = 0; i < n; i++) {
        float u = l->disc[2 * i] * c - l->disc[2 * i + 1] * s;
        float v = l->disc[2 * i] * s + l->disc[2 * i + 1] * c;
        lit += (uint32_t)envsh__is_lit(l, r, envsh__texel_index(r->x + u * a[0] + v * b[0]),
                                       envsh__texel_index(r->y + u * a[1] + v * b[1]));
    }
    return (float)lit / (float)n;
}

/* Shortens half axes that are longer than `most` texels, and lengthens those below 0.7 texels, with which all
   taps could fall into one texel. */
static void envsh__limit_axes(float *a, float *b, float most)
{
    float la = sqrtf(a[0] * a[0] + a[1] * a[1]), lb = sqrtf(b[0] * b[0] + b[1] * b[1]), least = 0.7f, f;
    f = la > most ? most / la : 1.0f;
    a[0] *= f;
    a[1] *= f;
    la *= f;
    f = lb > most ? most / lb : 1.0f;
    b[0] *= f;
    b[1] *= f;
    lb *= f;
    least = least < most ? least : most;
    if (la < least) {
        a[0] = least;
        a[1] = 0.0f;
        b[0] = 0.0f;
        b[1] = least;
    } else if (lb < least) {
        b[0] = -a[1] * (least / la);
        b[1] = a[0] * (least / la);
    }
}

/* Returns a component of a half axis, at most 1e15, so that its square is a float. envsh__limit_axes shortens
   such an axis in any case. */
static float envsh__hold_number(float x) { return x < -1e15f ? -1e15f : x > 1e15f ? 1e15f : x; }

/* Writes the half axes of a kernel in which a light spreads over a distance, given as a depth. */
static void envsh__make_kernel(const envsh__lookup *l, float distance, float *a, float *b)
{
    const float *spread = l->view->spread;
    int k;
    distance = distance > 0.0f ? distance * l->query->extent_scale : 0.0f;
    distance = distance < 1e9f ? distance : 1e9f;
    for (k = 0; k < 2; k++) {
        a[k] = envsh__hold_number(spread[k] * distance);
        b[k] = envsh__hold_number(spread[2 + k] * distance);
    }
    envsh__limit_axes(a, b, l->query->radius);
}

/* Returns the lit share by percentage-closer soft shadows for a directional light (Fernando 2005; the paper's
   future work): finds the mean depth of what is in the way, then filters by a kernel as wide as the light's
   extent spreads over the distance to that depth. */
static float envsh__filter_penumbra(const envsh__lookup *l, const envsh__receiver *r, float c, float s)
{
    const envsh_query *q = l->query;
    float a[2], b[2], occluders = 0.0f;
    uint32_t i, found = 0;
    int32_t x, y;
    int known;
    envsh__make_kernel(l, r->z, a, b);
    known = envsh__decide_by_cells(l, r, fabsf(a[0]) + fabsf(b[0]), fabsf(a[1]) + fabsf(b[1]));
    if (known >= 0) return (float)known;
    for (i = 0; i < q->tap_count; i++) {
        float u = l->disc[2 * i] * c - l->disc[2 * i + 1] * s;
        float v = l->disc[2 * i] * s + l->disc[2 * i + 1] * c;
        x = envsh__texel_index(r->x + u * a[0] + v * b[0]);
        y = envsh__texel_index(r->y + u * a[1] + v * b[1]);
        if (envsh__is_lit(l, r, x, y)) continue;
        occluders += l->tile[(size_t)y * l->row + (size_t)x * l->step];
        found++;
    }
    if (!found) return 1.0f;
    envsh__make_kernel(l, r->z - occluders / (float)found, a, b);
    return envsh__filter_taps(l, r, a, b, c, s);
}

/* Moves the point along its normal by the bias, and finds its place and its plane in the tile. cosine is that
   of normal and light, above 0. */
static void envsh__place_receiver(const envsh_view *v, const envsh_query *q, envsh__v3 p, envsh__v3 n,
                                  float cosine, envsh__receiver *r)
{
    const float *m = v->lookup;
    float nu = envsh__v3_dot(n, envsh__v3_load(v->right)), nv = envsh__v3_dot(n, envsh__v3_load(v->up));
    float texel = v->texel[0] > v->texel[1] ? v->texel[0] : v->texel[1], sine = sqrtf(nu * nu + nv * nv);
    float steep;
    p = envsh__v3_madd(p, n, q->bias * texel * (0.25f + 0.75f * sine));
    r->x = m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
    r->y = m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7];
    r->z = m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11];
    steep = 1.0f / ((cosine > 0.1f ? cosine : 0.1f) * v->depth_range);
    r->gx = nu * steep * v->texel[0];
    r->gy = nv * steep * v->texel[1];
    r->texel_depth = texel / v->depth_range;
    envsh__set_limit(r, q->filter == ENVSH_FILTER_PENUMBRA ? 1.0f : 0.0f);
}

/* Returns how much of the light reaches a point, 0..1, by the query's filter. n is the geometric normal,
   cosine that of n and the light, above 0. */
static float envsh__find_visibility(const envsh__lookup *l, envsh__v3 p, envsh__v3 n, float cosine,
                                    uint32_t index)
{
    const envsh_query *q = l->query;
    envsh__receiver r;
    float c, s, a[2], b[2];
    int known;
    envsh__place_receiver(l->view, q, p, n, cosine, &r);
    if (!envsh__finite(r.x) || !envsh__finite(r.y) || !envsh__finite(r.z)) return 1.0f;
    if (q->filter == ENVSH_FILTER_PLAIN)
        return (float)envsh__is_lit(l, &r, envsh__texel_index(r.x), envsh__texel_index(r.y));
    if (q->filter != ENVSH_FILTER_PENUMBRA) {
        float reach = q->filter == ENVSH_FILTER_SMOOTH ? q->radius + 1.0f : q->radius;
        envsh__set_limit(&r, reach);
        known = envsh__decide_by_cells(l, &r, reach, reach);
        if (known >= 0) return (float)known;
        if (q->filter == ENVSH_FILTER_SMOOTH) return envsh__filter_smooth(l, &r);
    }
    envsh__sincos(6.28318531f * envsh__to_unit(envsh__hash_combine(q->seed, l->first + index)), &s, &c);
    if (q->filter == ENVSH_FILTER_PENUMBRA) return envsh__filter_penumbra(l, &r, c, s);
    a[0] = b[1] = q->radius;
    a[1] = b[0] = 0.0f;
    return envsh__filter_taps(l, &r, a, b, c, s);
}

/* Fills in n points that lie evenly over the unit disc, on Vogel's spiral. */
static void envsh__fill_disc(float *disc, uint32_t n)
{
    uint32_t i;
    for (i = 0; i < n; i++) {
        float radius = sqrtf(((float)i + 0.5f) / (float)n), s, c;
        envsh__sincos(2.39996323f * (float)i, &s, &c);
        disc[2 * i] = radius * c;
        disc[2 * i + 1] = radius * s;
    }
}

/* Writes the least and the largest radius that a filter may have, in texels. */
static void envsh__radius_range(envsh_filter filter, float *least, float *most)
{
    *least = filter == ENVSH_FILTER_SMOOTH ? 0.5f : 0.0f;
    *most = filter == ENVSH_FILTER_SMOOTH ? 8.0f : filter == ENVSH_FILTER_PCF ? 32.0f : 64.0f;
}

/* Returns what the value of a setting means: 0 the default, a negative number 0. */
static float envsh__or_default(float value, float standard)
{
    return value < 0.0f ? 0.0f : value > 0.0f ? value : standard;
}

/* Copies the query, which may be NULL, fills in its defaults, and checks its fields. */
static envsh_result envsh__check_query(const envsh_query *query, envsh_query *q, const envsh__logger *log)
{
    static const char *const ranges[] = { "at most 64 texels", "0 (= 2) or 0.5..8 texels",
                                         "at most 32 texels" };
    const envsh_result bad = ENVSH_ERR_DESC;
    float least, most;
    memset(q, 0, sizeof *q);
    if (query) *q = *query;
    if ((unsigned)q->filter >= ENVSH_FILTER_COUNT)
        return envsh__refuse(log, "query.filter", q->filter, "one of envsh_filter", bad);
    if (q->filter == ENVSH_FILTER_DEFAULT) q->filter = ENVSH_FILTER_PENUMBRA;
    if (!(q->bias <= 1e6f))
        return envsh__refuse(log, "query.bias", (double)q->bias, "at most 1e6 texels", bad);
    q->bias = envsh__or_default(q->bias, 1.0f);
    if (!q->tap_count) q->tap_count = 16;
    if (q->filter == ENVSH_FILTER_PLAIN) return ENVSH_OK;
    envsh__radius_range(q->filter, &least, &most);
    if (!(q->radius <= most) || (q->radius < least && q->filter == ENVSH_FILTER_SMOOTH && q->radius != 0.0f))
        return envsh__refuse(log, "query.radius", (double)q->radius,
                             ranges[q->filter == ENVSH_FILTER_SMOOTH ? 1 : q->filter == ENVSH_FILTER_PCF ? 2
                                    : 0], bad);
    q->radius = envsh__or_default(q->radius, q->filter == ENVSH_FILTER_PENUMBRA ? 12.0f : 2.0f);
    if (q->filter == ENVSH_FILTER_SMOOTH) return ENVSH_OK;
    if (q->tap_count > ENVSH_MAX_TAPS)
        return envsh__refuse(log, "query.tap_count", q->tap_count, "0 (= 16) or 1..64", bad);
    if (!(q->extent_scale <= 1e6f))
        return envsh__refuse(log, "query.extent_scale", (double)q->extent_scale, "at most 1e6", bad);
    q->extent_scale = envsh__or_default(q->extent_scale, 1.0f);
    return ENVSH_OK;
}

/* ==== src/envshadow/shade.h ==== */

/* ---- shade: all lights at many points ---- */

#define ENVSH__BATCH 256u           /* points of a task */
#define ENVSH__ALL UINT32_MAX       /* in place of the number of one light */

typedef struct envsh__shading {
    const envsh_maps  *maps;
    const envsh_query *query;       /* with its defaults filled in */
    const envsh_points *points;
    float    *out;                  /* the visibility of one light, or the irradiance of all */
    uint32_t  only;                 /* the number of that one light, or ENVSH__ALL */
    float     disc[2 * ENVSH_MAX_TAPS];     /* taps on the unit disc */
} envsh__shading;

/* Adds one light to a batch of points. Lights come one after the other, not points, so that the texels of a
   tile are used while they are in the cache. */
static void envsh__shade_light(const envsh__shading *s, uint32_t light, size_t begin, size_t end)
{
    const envsh_maps *m = s->maps;
    const envsh_points *r = s->points;
    const envsh_view *v = &m->views[light];
    envsh__v3 d = envsh__v3_load(v->direction);
    envsh__lookup l;
    size_t i;
    int c;
    l.view = v;
    l.tile = envsh__tile_texels(m, light, &l.row);
    l.cells = m->bounds + 2 * (size_t)light * m->cells * m->cells;
    l.step = m->channels;
    l.size = (int32_t)m->map_side;
    l.cells_wide = (int32_t)m->cells;
    l.query = s->query;
    l.first = r->first;
    l.disc = s->disc;
    for (i = begin; i < end; i++) {
        envsh__v3 p = envsh__load_item(r->positions, r->position_stride, i);
        envsh__v3 n = envsh__load_item(r->normals, r->normal_stride, i);
        envsh__v3 flat = r->geometric_normals
                         ? envsh__load_item(r->geometric_normals, r->geometric_normal_stride, i) : n;
        float cosine = envsh__v3_dot(n, d), side = r->geometric_normals ? envsh__v3_dot(flat, d) : cosine;
        float visible;
        if (s->only != ENVSH__ALL) {
            s->out[i] = side > 0.0f &&
                        envsh__v3_finite(p) ? envsh__find_visibility(&l, p, flat, side, (uint32_t)i) : 0.0f;
            continue;
        }
        if (!(cosine > 0.0f) || !(side > 0.0f) || !envsh__finite(cosine) || !envsh__v3_finite(p)) continue;
        visible = envsh__find_visibility(&l, p, flat, side, (uint32_t)i) * cosine;
        for (c = 0; c < 3; c++) s->out[3 * i + (size_t)c] += visible * v->irradiance[c];
    }
}

/* Shades a batch of points. */
static void envsh__shade_task(void *context, size_t batch)
{
    const envsh__shading *s = (const envsh__shading *)context;
    size_t begin = batch * ENVSH__BATCH, end = begin + ENVSH__BATCH, i;
    uint32_t light;
    if (end > s->points->count) end = s->points->count;
    if (s->only != ENVSH__ALL) {
        envsh__shade_light(s, s->only, begin, end);
        return;
    }
    for (i = 3 * begin; !s->query->add && i < 3 * end; i++) s->out[i] = 0.0f;
    for (light = 0; light < s->maps->count; light++) envsh__shade_light(s, light, begin, end);
}

/* Returns the number of the first normal that is finite but neither unit nor 0 0 0, or count if there is
   none. */
static size_t envsh__find_bad_normal(const float *normals, size_t stride, size_t count)
{
    size_t i;
    for (i = 0; normals && i < count; i++) {
        envsh__v3 n = envsh__load_item(normals, stride, i);
        if (!envsh__is_unit(n) && envsh__v3_finite(n) && (n.x != 0.0f || n.y != 0.0f || n.z != 0.0f))
            return i;
    }
    return count;
}

/* Checks the lengths of normals, which may be NULL. */
static envsh_result envsh__check_normals(const char *field, const float *normals, size_t stride, size_t count,
                                         const envsh__logger *log)
{
    size_t i = envsh__find_bad_normal(normals, stride, count);
    if (i == count) return ENVSH_OK;
    envsh__log_element(log, field, i, "has the length",
                       (double)envsh__v3_length(envsh__load_item(normals, stride, i)),
                       "1 (0.97..1.03), or 0");
    return ENVSH_ERR_INPUT;
}

/* Checks points and the output, whose name is for the log. */
static envsh_result envsh__check_points(const envsh_points *p, const void *out, const char *name,
                                        const envsh__logger *log)
{
    const envsh_result bad = ENVSH_ERR_ARGUMENT;
    envsh_result result;
    if (!p) return envsh__refuse_text(log, "points", "is NULL", bad);
    if (!envsh__stride_fits(p->position_stride))
        return envsh__refuse_stride(log, "points.position_stride", p->position_stride);
    if (!envsh__stride_fits(p->normal_stride))
        return envsh__refuse_stride(log, "points.normal_stride", p->normal_stride);
    if (!envsh__stride_fits(p->geometric_normal_stride))
        return envsh__refuse_stride(log, "points.geometric_normal_stride", p->geometric_normal_stride);
    if (!p->count) return ENVSH_OK;
    if (!p->positions) return envsh__refuse_text(log, "points.positions", "is NULL", bad);
    if (!p->normals) return envsh__refuse_text(log, "points.normals", "is NULL", bad);
    if (!out) return envsh__refuse_text(log, name, "is NULL", bad);
    result = envsh__check_normals("points.normals", p->normals, p->normal_stride, p->count, log);
    if (result != ENVSH_OK) return result;
    return envsh__check_normals("points.geometric_normals", p->geometric_normals, p->geometric_normal_stride,
                                p->count, log);
}

/* Shades points by a query whose defaults are filled in. Both have been checked. */
static envsh_result envsh__run_shading(const envsh_maps *m, const envsh_query *q, const envsh_points *points,
                                       float *out, uint32_t only)
{
    envsh__shading s;
    size_t batches = points->count / ENVSH__BATCH + (points->count % ENVSH__BATCH != 0);
    s.maps = m;
    s.query = q;
    s.points = points;
    s.out = out;
    s.only = only;
    envsh__fill_disc(s.disc, q->tap_count <= ENVSH_MAX_TAPS ? q->tap_count : 1);
    return envsh__run_steps(m, batches, envsh__shade_task, &s);
}

/* Checks whether maps can be shaded with: they have texels, and envsh_maps_end came after the last change. */
static envsh_result envsh__check_finished(const envsh_maps *m, const envsh__logger *log)
{
    if (m->no_depth) return envsh__refuse_no_depth(log);
    if (m->phase != 2) return envsh__refuse_text(log, "envsh_maps_end", "must come first", ENVSH_ERR_ORDER);
    return ENVSH_OK;
}

ENVSH_DEF envsh_result envsh_shade(const envsh_maps *maps, const envsh_query *query,
                                   const envsh_points *points, float *irradiance)
{
    envsh__logger logger;
    envsh_query q;
    envsh_result result;
    if (!maps) return ENVSH_ERR_ARGUMENT;
    logger = envsh__make_logger(&maps->system, "envsh_shade");
    result = envsh__check_query(query, &q, &logger);
    if (result == ENVSH_OK) result = envsh__check_points(points, irradiance, "irradiance", &logger);
    if (result == ENVSH_OK) result = envsh__check_finished(maps, &logger);
    return result == ENVSH_OK ? envsh__run_shading(maps, &q, points, irradiance, ENVSH__ALL) : result;
}

ENVSH_DEF envsh_result envsh_visible(const envsh_maps *maps, uint32_t light, const envsh_query *query,
                                     const envsh_points *points, float *visible)
{
    envsh__logger logger;
    envsh_query q;
    envsh_result result;
    if (!maps) return ENVSH_ERR_ARGUMENT;
    logger = envsh__make_logger(&maps->system, "envsh_visible");
    result = envsh__check_query(query, &q, &logger);
    if (result == ENVSH_OK) result = envsh__check_points(points, visible, "visible", &logger);
    if (result == ENVSH_OK) result = envsh__check_finished(maps, &logger);
    if (result == ENVSH_OK && light >= maps->count) result = envsh__refuse_light(&logger, light, maps->count);
    return result == ENVSH_OK ? envsh__run_shading(maps, &q, points, visible, light) : result;
}

ENVSH_DEF float envsh_visibility_twin(const envsh_tile *tile, const envsh_query *query, const float point[3],
                                      const float geometric_normal[3], uint32_t index)
{
    static const envsh__logger silent = { NULL, NULL, "envsh_visibility_twin" };
    float disc[2 * ENVSH_MAX_TAPS], cosine;
    envsh_query q;
    envsh__v3 n;
    envsh__lookup l;
    if (!tile || !tile->view || !tile->depth || !point || !geometric_normal) return 0.0f;
    if (envsh__check_query(query, &q, &silent) != ENVSH_OK) return 0.0f;
    n = envsh__v3_load(geometric_normal);
    if (!envsh__is_unit(n)) return 0.0f;
    memset(&l, 0, sizeof l);
    envsh__fill_disc(disc, q.tap_count <= ENVSH_MAX_TAPS ? q.tap_count : 1);
    l.view = tile->view;
    l.tile = tile->depth;
    l.row = tile->row_stride / 4;
    l.step = tile->texel_stride / 4;
    l.size = (int32_t)tile->side;
    l.query = &q;
    l.disc = disc;
    cosine = envsh__v3_dot(n, envsh__v3_load(tile->view->direction));
    return cosine > 0.0f ? envsh__find_visibility(&l, envsh__v3_load(point), n, cosine, index) : 0.0f;
}

/* ==== src/envshadow/clusters.h ==== */

/* ---- clusters: algorithm 2, some lights at a time ---- */

/* Returns the address of element `first` of an array, or NULL for NULL. */
static const float *envsh__skip_items(const float *base, size_t stride, uint32_t first)
{
    return base ? (const float *)(const void *)((const char *)base + first * (stride ? stride : 12)) : NULL;
}

/* Returns the lights from number `first` on, as many as the maps hold. */
static envsh_lights envsh__cluster_at(const envsh_lights *lights, uint32_t first, uint32_t capacity)
{
    envsh_lights part = *lights;
    part.count = lights->count - first < capacity ? lights->count - first : capacity;
    part.directions = envsh__skip_items(lights->directions, lights->stride, first);
    part.irradiances = envsh__skip_items(lights->irradiances, lights->stride, first);
    part.axes_u = envsh__skip_items(lights->axes_u, lights->stride, first);
    part.axes_v = envsh__skip_items(lights->axes_v, lights->stride, first);
    return part;
}

ENVSH_DEF envsh_result envsh_illuminate(envsh_maps *maps, const envsh_lights *lights, envsh_bounds bounds,
                                        envsh_draw_fn draw_fn, void *user, const envsh_query *query,
                                        const envsh_points *points, float *irradiance)
{
    envsh_query q;
    envsh_lights part;
    envsh__logger logger;
    envsh_result result;
    uint32_t first = 0, count = lights ? lights->count : 0;
    if (!maps) return ENVSH_ERR_ARGUMENT;
    logger = envsh__make_logger(&maps->system, "envsh_illuminate");
    if (!draw_fn) return envsh__refuse_text(&logger, "draw_fn", "is NULL", ENVSH_ERR_ARGUMENT);
    if (maps->no_depth) return envsh__refuse_no_depth(&logger);
    if (!maps->capacity && count)
        return envsh__refuse_text(&logger, "capacity", "is 0: no light has room", ENVSH_ERR_LIMIT);
    result = lights ? envsh__check_lights(lights, &logger) : ENVSH_OK;
    if (result == ENVSH_OK) result = envsh__check_bounds(&bounds, &logger);
    if (result == ENVSH_OK) result = envsh__check_query(query, &q, &logger);
    if (result == ENVSH_OK) result = envsh__check_points(points, irradiance, "irradiance", &logger);
    if (result != ENVSH_OK) return result;
    memset(&part, 0, sizeof part);
    do {
        if (lights) part = envsh__cluster_at(lights, first, maps->capacity);
        maps->told = count ? (float)first / (float)count : 0.0f;
        maps->span = 0.0f;
        result = envsh_maps_begin(maps, &part, bounds);
        if (result == ENVSH_OK && part.count) result = draw_fn(user, maps);
        if (result == ENVSH_OK) result = envsh_maps_end(maps);
        maps->span = (count ? (float)(first + part.count) / (float)count : 1.0f) - maps->told;
        if (result == ENVSH_OK) result = envsh__check_finished(maps, &logger);
        if (result == ENVSH_OK) result = envsh__run_shading(maps, &q, points, irradiance, ENVSH__ALL);
        q.add = 1;
        first += part.count;
    } while (result == ENVSH_OK && first < count);
    maps->told = 0.0f;
    maps->span = 1.0f;
    return result;
}

/* ---- cost: what a pass and a light cost, from measured times ---- */

ENVSH_DEF int envsh_cost_fit(uint32_t light_count, const uint32_t *clusters, const double *ms, size_t count,
                             envsh_cost *out)
{
    double aa = 0.0;
    double ab = 0.0;
    double bb = 0.0;
    double at = 0.0;
    double bt = 0.0;
    double det;
    size_t i;
    if (!clusters || !ms || !out || !light_count) return 0;
    for (i = 0; i < count; i++) {
        double passes, slots;
        if (!clusters[i] || !(ms[i] >= 0.0 && ms[i] < 1e12)) return 0;
        passes = (double)((light_count - 1) / clusters[i] + 1);
        slots = passes * (double)clusters[i];
        /* Least squares of relative errors: each row is divided by its time. */
        passes /= ms[i] + 1e-9;
        slots /= ms[i] + 1e-9;
        aa += passes * passes;
        ab += passes * slots;
        bb += slots * slots;
        at += passes * ms[i] / (ms[i] + 1e-9);
        bt += slots * ms[i] / (ms[i] + 1e-9);
    }
    det = aa * bb - ab * ab;
    if (!(det > 1e-9 * aa * bb)) return 0;
    out->pass = (at * bb - bt * ab) / det;
    out->slot = (bt * aa - at * ab) / det;
    if (out->pass < 0.0) {                  /* by noise; then the other cost explains all of the times */
        out->pass = 0.0;
        out->slot = bt / bb;
    } else if (out->slot < 0.0) {
        out->slot = 0.0;
        out->pass = at / aa;
    }
    return 1;
}

ENVSH_DEF uint32_t envsh_cost_cluster(const envsh_cost *cost, uint32_t light_count, uint32_t most)
{
    uint32_t best = 1, c;
    double least = -1.0;
    if (!cost || !light_count || !most) return 1;
    most = most < light_count ? most : light_count;
    for (c = 1; c <= most; c++) {
        double passes = (double)((light_count - 1) / c + 1);
        double ms = passes * (cost->pass + (double)c * cost->slot);
        if (least >= 0.0 && ms >= least) continue;
        least = ms;
        best = c;
    }
    return best;
}

/* ==== src/shared/fp_end.h ==== */

/* unit fp_end: the user's options again. clang and MSVC keep contraction off to the end of the file. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__)
#pragma GCC pop_options
#endif

/* ==== src/envshadow/end.h ==== */

#endif /* ENVSHADOW_IMPLEMENTATION */

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
