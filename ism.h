/* ism.h - v0.9.0 - imperfect, view-adaptive shadow maps: bounced light with its shadows - MIT-0 OR Unlicense

   What it does

   This header computes bounced light with its shadows. It chooses a thousand virtual point lights (VPLs)
   among lit surface points (the texels of a reflective shadow map, points on lamps, directions of a sky),
   gives each a small hemispherical depth map, drawn from a few thousand surfels scattered over all triangles,
   and lights pixels or any list of points by them. After Ritschel, Eisemann, Ha, Kim and Seidel, "Making
   Imperfect Shadow Maps View-Adaptive", Computer Graphics Forum 30(8), 2011: VPLs are chosen by what they do
   to the picture, and surfels are dense where they shadow what the picture shows. Scene, light and camera may
   all change from frame to frame.

   What it does not do

   - You render direct light and reflective shadow maps, and hand over plain arrays.
   - Each VPL's depth map is coarse (64 x 64 texels from 8,192 surfels): single indirect shadows are blurred
     and leak; the sum over a thousand VPLs is what counts. docs/ism.md has pictures, docs/measured/ism.md
     figures.
   - Surfaces that receive light are diffuse; VPLs are diffuse or cosine-power lobes.
   - The header opens no files and starts no threads.

   Quick start

   In exactly one source file write the define; everywhere else include the header alone.

       #define ISM_IMPLEMENTATION
       #include "ism.h"
       #include <stdio.h>
       #include <string.h>

       int main(void)
       {
           // a lit floor texel of 1 m^2 (flux = albedo x irradiance x area), and two receivers under the
           // ceiling, one of them above a table top
           static const float corners[] = { 1, 1, -1,  3, 1, -1,  3, 1, 1,  1, 1, 1 };
           static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2 };
           const float at[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 }, flux[3] = { 1.5f, 1.5f, 1.5f };
           const float positions[6] = { -4, 2, 0,  4, 2, 0 }, down[6] = { 0, -1, 0,  0, -1, 0 };
           ism_desc desc;
           ism_mesh mesh;
           ism_source source;
           ism_points points;
           ism_frame frame;
           float light[6];
           ism_maps *maps;

           memset(&desc, 0, sizeof desc);
           memset(&mesh, 0, sizeof mesh);
           memset(&source, 0, sizeof source);
           memset(&points, 0, sizeof points);
           memset(&frame, 0, sizeof frame);
           desc.vpl_count = 1;
           mesh.positions = corners;
           mesh.vertex_count = 4;
           mesh.indices = triangles;
           mesh.index_count = 6;
           source.width = source.height = 1;
           source.positions = at;
           source.normals = up;
           source.fluxes = flux;
           points.count = 2;
           points.positions = positions;
           points.normals = down;
           frame.mesh = &mesh;
           frame.sources = &source;
           frame.source_count = 1;
           frame.points = &points;
           if (ism_create(&desc, &maps) != ISM_OK) return 1;
           if (ism_render(maps, &frame, NULL, light, NULL) != ISM_OK) return 1;
           printf("open side %g W/m^2, behind the table top %g\n", (double)light[0], (double)light[3]);
           ism_free(maps);
           return !(light[0] > 0.0f && light[3] == 0.0f);
       }

   Conventions

   Space is right-handed. Matrices are column-major float[16]. Directions point from the surface to the light.
   Vectors called unit may be 0.97 to 1.03 long and are used as they are. Distances are in your units (m
   below), angles in radians, radiance in W/(sr m^2), irradiance in W/m^2, flux in W.

     pVPL       a texel of a source, which might become a light: position, normal, reflected flux
     BRSM       bidirectional reflective shadow map: the importances of a source's texels, flux times effect
                on the picture (ism_importance says which effect)
     VPL        a pVPL that was chosen, its flux divided by N and by the probability of the choice
     tile       the depth map of one VPL: tile_side^2 texels of the hemisphere about its normal; the atlas has
                all of them
     surfel     a point of a triangle as an occluder: a disc of the area that the point stands for
     receiver   a point that is lit: a pixel of the view, or an element of any list
     near point a light of a second, finer choice, which takes the place of VPLs that are close to a receiver

   How it works

     sources -> importance -> prefix sums -> VPLs            ism_choose
     mesh    -> solid angles -> prefix sums -> surfels       ism_build (ism_scatter alone makes no maps)
     surfels -> discs in tiles -> pull and push -> atlas     ism_build
     VPLs, atlas, receivers -> light -> blur                 ism_shade

       atlas: ceil(sqrt(N)) tiles a side       tile: the square holds the hemisphere
       +----+----+----+----+                   +---------+  a disc of the unit hemisphere seen from above
       | v0 | v1 | v2 | v3 |                   |  ,---.  |  (COSINE), stretched to fill the square (Shirley
       +----+----+----+----+                   | ( axis) |  and Chiu's concentric map): every texel has the
       | v4 | v5 | ...                         |  `---'  |  same share of the light that leaves a diffuse VPL
       +----+----                              +---------+

   A tile shows the square unevenly: the window, that part of the square in which the picture lies, has all
   texels of the tile but 8 of 64 a side (ism_zoom). Each surfel belongs to one VPL.

   From the paper to the code

     section 3.2          importance by flux, as before the paper       ism__add_shares       T41
     section 3.3          points drawn into the maps of all VPLs        ism__draw_points      T48, T50
     section 3.3          pull and push                                 ism__pull, ism__fill  T49
     section 4, figure 3  bidirectional importance by few receivers     ism__estimate_effect  T41
     section 4            flux over N and probability                   ism__make_vpl         T41
     section 4.1          prefix sums, VPL i at i / N                   ism__draw_vpl         T15, T16
     section 4.2          receivers near the texel's place              ism__to_pixel,
                                                                        ism__estimate_effect  T41
     section 5.1, fig. 6  solid angle of triangles, prefix sums         ism__solid_angle,
                                                                        ism__make_cdf         T52, T53
     section 5.1          a surfel's place in its triangle              ism__triangle_map     T51
     section 5.2          eight receivers for each triangle             ism__seen_by_view     T53
     section 5.3          an eighth of the surfels a frame              ism__points_of,
                                                                        ism_desc              T54, T57
     section 6.1          maps of equal flux, of lobes                  ism_map_direction,
                                                                        ism_map_coordinates   T46, T47
     section 6.2          subsets of VPLs, blur along surfaces          ism__shade_pixel,
                                                                        ism__smooth_pixel     -
     section 6.3          corners of triangles from indexed meshes      ism_mesh, ism__corners -
     section 6.4          dithered opacity                              ism_mesh, ism__dither T58
     section 6.5          blur of the BRSM                              ism__blur_task        T41
     section 6.5          VPLs between texels                           ism__inter_texel      T55
     ISM of 2008          the next bounce, from imperfect RSMs          ism_bounce            T45
     -                    light close to a VPL                          ism__patch_kernel     T42, T43, T44
     -                    VPLs that no pixel of a block can see         ism__cull             T56
     -                    clusters of triangles, seen by a VPL          ism__cluster_effect   -
     -                    windows                                       ism_zoom, ism_unzoom  -
     -                    near points                                   ism_near_points       -

   T.. are rows of docs/conformance.md. Where there is a -, the paper says nothing that a row could expect:
   tests/ism/sums_test.c computes interleaved pictures, clusters and the light of near points anew in doubles,
   window_test.c tests windows, near_test.c the choice of near points.

   docs/ism.md lists where and why the code departs from the paper.

   Knobs, and what each trades

     vpl_count     fewer: blotches where VPLs are near a surface; time and memory are proportional to it
     surfel_count  fewer: shadows of small things blur and vanish; memory 12 bytes each, times vpl_count
     spread        PAIR spends most surfels on what both the picture and the VPL see; the others are those of
                   the papers
     tile_side     smaller: light leaks round corners, contact shadows vanish
     window_rim    less: coarser maps of what the picture does not show; more: coarser maps of what it shows
     interleave    larger: 1 / interleave^2 of the shading time, but for that of near points, and details
                   of indirect shadows blurred over as many pixels
     bias          less: acne; more: light leaks in corners
     lazy_frames   renewing all surfels every frame (1) adapts at once, and flickers

   Configuration

     ISM_IMPLEMENTATION   in one source file: compiles the code
     ISM_STATIC           beside it: a private copy, all functions static
     ISM_DEF              everywhere: your own linkage instead
     ISM_NO_SIMD          with the implementation: portable code only (results are the same to the bit)
     ISM_FILE             with the implementation: this file's name, if it is not "ism.h". The file includes
                          itself for AVX2 and AVX-512; where it cannot, it does without them

   Memory, errors, threads, determinism

   All memory comes from the allocator in desc.system, called from the thread that called us. It grows to the
   largest frame and is kept, in bytes, with less than 8 KB besides:

     12 N surfels + 4 A + 4 A (if keep_hits) + 2444 tile_side^2 + 16 triangles + 768 clusters of triangles +
     832 bundles of clusters + 20 pVPLs + 16 rows of pVPLs + 40 sources + 4 pixels + 244 N + 112.25 N near
     points. A = (ceil(sqrt(N)) tile_side)^2; clusters are all triangles, or equal numbers of them, 32,768
     clusters at most; bundles = 1 + clusters / 16, rounded down.
     1024 VPLs, 8192 surfels, 64^2 texels: 101 + 17 + 12 MB

   While ism_shade runs: 12 pixels + 12 pixels (if interleaved) + 32 for each block of 16 x 16 pixels + 64 N
   more.

   Every function that can fail returns an ism_result. If the result is not ISM_OK, outputs are untouched,
   nothing leaks, and desc.system.log gets a line that says which field or element is wrong; where maps is
   NULL, there is no log. There are no globals. An ism_maps belongs to one thread at a time, but calls that
   take it as const may run together. Results are equal to the bit for the same input, seed and frame index,
   on every compiler, processor and thread count (not with x87 arithmetic, nor with clang's -ffast-math).

   Cost: docs/measured/performance.md and build/bench ism.   History: CHANGELOG.md.
   Licence: end of this file. */
#ifndef ISM_H
#define ISM_H

#define ISM_VERSION 900 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "ism.h needs C99 or C++11"
#endif
#if defined(ISM_STATIC) && !defined(ISM_IMPLEMENTATION)
#error "ISM_STATIC makes all functions private: ISM_IMPLEMENTATION belongs into the same file"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef ISM_DEF
#ifdef ISM_STATIC
#define ISM_DEF static inline
#else
#define ISM_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/ism/api.h ==== */

/* ---- page one: enough to light a picture ---- */

#define ISM_RESULTS(X)                                                                                       \
    X(ISM_OK, "ok")                                                                                          \
    X(ISM_ERR_ARGUMENT, "a pointer is NULL, or a count or stride is out of range")                           \
    X(ISM_ERR_DESC, "a field of a desc is out of range")                                                     \
    X(ISM_ERR_INPUT, "the data cannot be used")                                                              \
    X(ISM_ERR_ALLOC, "the allocator returned no memory")                                                     \
    X(ISM_ERR_MEMORY, "the caller's memory is too small or misaligned")                                      \
    X(ISM_ERR_LIMIT, "a size overflows or passes a limit")                                                   \
    X(ISM_ERR_CANCELLED, "cancelled by the progress callback")                                               \
    X(ISM_ERR_ORDER, "this call comes too early, too late or twice")                                         \
    X(ISM_ERR_FORMAT, "not a file of this kind, or a damaged one")                                           \
    X(ISM_ERR_VERSION, "a file of an unknown version")                                                       \
    X(ISM_ERR_MISMATCH, "what was given does not belong together")

typedef enum ism_result {
#define ISM__ENUM(name, text) name,
    ISM_RESULTS(ISM__ENUM)
#undef ISM__ENUM
    ISM_RESULT_COUNT
} ism_result;

typedef struct ism_maps ism_maps;       /* VPLs with their surfels and depth maps, kept from frame to frame */
typedef struct ism_desc ism_desc;       /* how many VPLs, and how large their maps: see settings, below */
typedef struct ism_shading ism_shading; /* how receivers are shaded: see settings */
typedef struct ism_stats ism_stats;     /* what a call counted: see settings */
typedef struct ism_frame ism_frame;     /* mesh, sources and receivers of one frame: below */

ISM_DEF ism_result ism_create(const ism_desc *desc, ism_maps **out);
/* Makes maps, which ism_free takes back. One ism_maps serves all frames.
   desc     NULL = all defaults
   out      written on ISM_OK only
   Errors   ISM_ERR_ARGUMENT: out is NULL.
            ISM_ERR_DESC: a field of desc is out of range, or the allocator has one function of two.
            ISM_ERR_ALLOC: there is no memory. */

ISM_DEF ism_result ism_render(ism_maps *maps, const ism_frame *frame, const ism_shading *shading, float *out,
                              ism_stats *stats);
/* Lights the frame's receivers: ism_choose, ism_build (if shading asks the maps) and ism_shade in one call.
   shading  NULL = all defaults
   out      3 floats for each receiver: irradiance in W/m^2, or radiance in W/(sr m^2) if the receivers have
            albedos; untouched on failure
   stats    may be NULL
   Errors   those of the three calls, of which ISM_ERR_ORDER cannot occur. */

ISM_DEF void ism_free(ism_maps *maps);
/* Takes back maps and their memory; NULL is allowed. */

ISM_DEF const char *ism_result_text(ism_result result);
/* Returns a constant text that says what a result means; "unknown result" for any other number. */

typedef int (*ism_mask_fn)(void *user, uint32_t triangle, const float weights[3]);
/* A function of yours that says whether a triangle is there: not 0, or 0 in a hole of its alpha mask. The
   weights of the triangle's corners, which add up to 1, say at which point. parallel_for's threads call the
   function. */

typedef struct ism_mesh {           /* the triangles that cast shadows, lit ones too, in world space, as of
                                       this frame */
    const float    *positions;      /* x, y, z of each vertex */
    size_t          vertex_count;
    size_t          vertex_stride;  /* bytes from one vertex to the next, a multiple of 4, >= 12; 0 = 12 */
    const uint32_t *indices;        /* three to a triangle; NULL = indices16, or else 0, 1, 2, ... */
    size_t          index_count;    /* a multiple of 3 (ignored without indices: vertex_count is used) */
    const uint16_t *indices16;      /* in place of indices; not both */
    const float    *opacities;      /* 0..1 for each triangle: the share of the VPLs, in quarters, into whose
                                       maps the triangle is drawn; NULL = all are opaque */
    const float    *albedos;        /* r, g, b of each triangle, read by ism_bounce alone; NULL = 0.5 */
    ism_mask_fn     mask_fn;        /* holes of an alpha mask: surfels that fall into one are none; NULL = no
                                       holes. Asked for surfels that a frame renews, so a change of the mask
                                       is seen after lazy_frames */
    void           *user;           /* given to mask_fn */
} ism_mesh;

typedef enum ism_source_kind {      /* what sends the light on */
    ISM_SOURCE_DEFAULT,             /* = ISM_SOURCE_SURFACE */
    ISM_SOURCE_SURFACE,             /* texels of a reflective shadow map, points on lamps */
    ISM_SOURCE_DIRECTIONS,          /* a sky: positions are unit directions to the sky, fluxes are radiance x
                                       solid angle, W/m^2. The maps of its VPLs are orthographic and show the
                                       mesh's bounding sphere */
    ISM_SOURCE_COUNT
} ism_source_kind;

typedef struct ism_source {         /* a grid of points that send light on (pVPLs): a lit surface, a lamp or a
                                       sky */
    ism_source_kind kind;
    uint32_t     width, height;     /* points a row and rows of the grid; all sources have 2^26 points at
                                       most. A plain list has height 1, and `scattered` is set */
    int          scattered;         /* not 0: neighbours in the grid are no neighbours in space, so VPLs lie
                                       on points, not between them, and effects are not blurred */
    const float *positions;         /* x, y, z of each */
    size_t       position_stride;   /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const float *normals;           /* unit; those of directions are not read */
    size_t       normal_stride;     /* as position_stride */
    const float *fluxes;            /* r, g, b, 0..1e30 W: what leaves the surface behind each texel; 0 if
                                       there is no surface. A texel with another flux is never chosen, and
                                       ism_stats.bad_pvpls counts it. The flux of a VPL is cut at 1e30 */
    size_t       flux_stride;       /* as position_stride */
    const float *areas;             /* m^2 of surface behind each texel. If areas is NULL, and where an area
                                       is negative or not finite, the distances between VPLs tell it */
    size_t       area_stride;       /* bytes, a multiple of 4; 0 = 4 */
    const float *lobes;             /* axis x, y, z (unit) and exponent 0..1e5 of each: its intensity goes as
                                       cos^exponent about the axis. NULL = diffuse, which is exponent 1 about
                                       the normal */
    size_t       lobe_stride;       /* bytes, a multiple of 4, >= 16; 0 = 16 */
} ism_source;

typedef enum ism_rows {             /* which row of a picture in memory comes first */
    ISM_ROWS_DEFAULT,               /* = ISM_ROWS_BOTTOM_FIRST */
    ISM_ROWS_BOTTOM_FIRST,          /* the row at clip y = -1, as in OpenGL and Vulkan */
    ISM_ROWS_TOP_FIRST,             /* the row at clip y = +1, as in Direct3D and Metal */
    ISM_ROWS_COUNT
} ism_rows;

typedef struct ism_points {         /* receivers: pixels of a picture, row by row, or any list */
    size_t       count;             /* 1..2^28 */
    const float *positions;         /* x, y, z of each */
    size_t       position_stride;   /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const float *normals;           /* unit; 0 0 0: no receiver, its result is 0 */
    size_t       normal_stride;     /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const float *geometric_normals; /* unit normals of the triangles, on whose planes depths are compared with
                                       those of maps; NULL, and 0 0 0 of one = normals */
    size_t       geometric_normal_stride;   /* as normal_stride */
    const float *albedos;           /* r, g, b of each; NULL: results are irradiances */
    size_t       albedo_stride;     /* as normal_stride */
    uint32_t     width;             /* pixels in a row of the picture, a divisor of count; 0 = a list */
    float        world_to_clip[16]; /* the camera's matrix, column-major; all 0 = unknown. The matrix tells
                                       which pixels lie near a texel of a source; clip z plays no part */
    ism_rows     rows;              /* of the picture */
} ism_points;

struct ism_frame {
    const ism_mesh   *mesh;         /* NULL: nothing casts shadows */
    const ism_source *sources;      /* such as the faces of a cube map, or several lights; may be NULL if
                                       source_count is 0 */
    size_t            source_count;
    const ism_points *points;       /* the receivers. VPLs are chosen for all of them together: if there are
                                       few, one that is very near a light draws most VPLs to itself, and the
                                       others are noisy, though right on the mean */
    uint32_t          index;        /* number of the frame, which decides which surfels are renewed */
};

/* ==== src/ism/api_settings.h ==== */

/* ---- settings ---- */

typedef struct ism_allocator {      /* all zero: malloc and free; else both functions */
    void *(*alloc_fn)(size_t bytes, void *user);    /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} ism_allocator;

typedef void (*ism_task)(void *context, size_t index);

typedef struct ism_system {         /* all zero: malloc and free, this thread alone, no progress, no log */
    ism_allocator allocator;        /* called from the thread that called us */
    void (*parallel_for)(void *user, size_t count, ism_task task, void *context);
    /* Must call task(context, i) once for each i < count, in any order and on any threads, and return when
       all are done. What is computed does not depend on the threads. */
    int (*progress)(void *user, float fraction);
    /* Called from the thread that called us, fraction 0..1 never falling within a call; not 0 cancels. */
    void (*log)(void *user, const char *message);
    /* Called at most once by a call that fails, from the thread that called us, before it returns: one line
       without a line end that names the function, the field or element, its value and its range. */
    void *user;                     /* given to parallel_for, progress and log */
} ism_system;

typedef enum ism_importance {       /* by which importance VPLs are chosen among the texels of sources */
    ISM_IMPORTANCE_DEFAULT,         /* = ISM_IMPORTANCE_GUIDED */
    ISM_IMPORTANCE_FLUX,            /* by the flux that leaves the texel (paper, section 3.2) */
    ISM_IMPORTANCE_BRSM,            /* by flux x effect on the picture (section 4.1). The effect is the root
                                       of a mean square: of what a unit of the texel's flux would add,
                                       unshadowed, to receivers at view_grid_side^2 jittered places of the
                                       picture. So the picture's variance is least. blur_radius blurs the mean
                                       square, flux_share adds a constant to its root */
    ISM_IMPORTANCE_GUIDED,          /* as BRSM, with half of the receivers near the texel's own place in the
                                       picture (section 4.2); such samples weigh less where they are denser */
    ISM_IMPORTANCE_BRSM_MEAN,       /* as BRSM, but the effect is the mean, as in the paper: VPLs are in
                                       proportion to the light that they add, not to the noise */
    ISM_IMPORTANCE_GUIDED_MEAN,     /* as GUIDED, but the effect is the mean */
    ISM_IMPORTANCE_COUNT
} ism_importance;

typedef enum ism_spread {           /* how surfels are spread over triangles */
    ISM_SPREAD_DEFAULT,             /* = ISM_SPREAD_PAIR */
    ISM_SPREAD_AREA,                /* by area, as in the imperfect shadow maps of 2008 */
    ISM_SPREAD_VIEW_1,              /* by the triangle's solid angle as seen from one receiver, the same for
                                       all triangles (section 5.1) */
    ISM_SPREAD_VIEW_8,              /* by the triangle's mean solid angle as seen from 8 receivers, which are
                                       drawn for each triangle (section 5.2) */
    ISM_SPREAD_PAIR,                /* by the geometric mean of VIEW_8 and of about the share of the VPL's own
                                       map that the triangle fills */
    ISM_SPREAD_COUNT
} ism_spread;

typedef enum ism_projection {       /* which directions the texels of a VPL's map show */
    ISM_PROJECTION_DEFAULT,         /* = ISM_PROJECTION_COSINE */
    ISM_PROJECTION_COSINE,          /* every texel has an equal share of a diffuse VPL's flux (section 6.1) */
    ISM_PROJECTION_PARABOLOID,      /* a disc in the square, whose corners are never used */
    ISM_PROJECTION_OCTAHEDRAL,      /* an octahedron's upper half, which takes no trigonometry; texels have
                                       0.6 to 1.7 times the mean solid angle */
    ISM_PROJECTION_LOBE,            /* every texel has an equal share of the flux of the VPL's own lobe */
    ISM_PROJECTION_COUNT
} ism_projection;

struct ism_desc {                   /* zero it, then set what you care about */
    ism_system     system;          /* kept: the maps' later calls use it too */
    uint32_t       vpl_count;       /* N, 1..16384; 0 = 1024 */
    uint32_t       surfel_count;    /* of each VPL, 8..65536; 0 = 8192 */
    uint32_t       tile_side;       /* texels a side of a VPL's map, a power of two, 8..256; 0 = 64 */
    ism_importance importance;
    ism_spread     spread;
    ism_projection projection;
    uint32_t       view_grid_side;  /* a texel's effect is estimated from a grid of receivers with this side,
                                       1..16; 0 = 4 */
    int32_t        blur_radius;     /* texels of a source along its surface, to either side, over which
                                       effects are blurred, at most 16; 0 = 5 % of the source's shorter side,
                                       at most 6; negative = no blur */
    uint32_t       lazy_frames;     /* frames until all surfels are renewed, 1..64; 0 = 8 */
    float          flux_share;      /* share of the choice that is made by flux alone, so that no texel is
                                       forgotten, up to 1; 0 = 0.1 */
    float          area_share;      /* share of the surfels that is spread by area, so that no triangle is
                                       forgotten, up to 1; 0 = 0.2 */
    float          splat_scale;     /* area of discs over that of their surfels, up to 16; 0 = 0.8. Discs that
                                       are cut off at their triangle's edges have 6 times the area, which
                                       closes gaps between them */
    int32_t        near_point_count;    /* near points for each VPL, at most 64; 0 = 16; negative = none. Near
                                       points take the VPL's place for receivers close by; if there are none,
                                       ISM_NEAR_GATHER does what ISM_NEAR_PATCH does */
    int32_t        window_rim;      /* texels a side of a tile that show what lies outside its window
                                       (ism_zoom), 2..tile_side / 2; 0 = tile_side / 8, at least 2; negative =
                                       tiles have no windows and show hemispheres evenly */
    int            no_inter_texel;  /* not 0: VPLs lie at texel centres of their source, not between them
                                       (section 6.5) */
    int            no_fill;         /* not 0: holes of maps stay open, without pull and push (section 3.3) */
    int            unstable;        /* not 0: every frame has new random numbers, so that the mean of many
                                       frames converges and single frames flicker; 0: frames stay alike */
    int            vary_surfels;    /* not 0: VPLs with less than a half or a quarter of the mean flux take a
                                       half or a quarter of the surfels */
    int            keep_hits;       /* not 0: the atlas keeps which triangles it shows, for ism_bounce, and
                                       tiles have no windows */
    uint32_t       seed;            /* chooses between equally good sets of random numbers */
};

typedef enum ism_near {             /* what is done where a receiver is so close to a VPL that a point's
                                       light would be a bright speck */
    ISM_NEAR_DEFAULT,               /* = ISM_NEAR_GATHER */
    ISM_NEAR_PATCH,                 /* the VPL is taken for a square of its area, whose exact form factor is
                                       computed. A receiver that faces the square gets no more than from a
                                       point, since it may be the back of a bent sheet */
    ISM_NEAR_SPHERE,                /* the VPL is taken for a virtual spherical light (Hasan et al. 2009) */
    ISM_NEAR_CLAMP,                 /* cos cos / d^2 is cut off at `clamp` */
    ISM_NEAR_CLAMP_MEAN,            /* a VPL's light is cut off at `clamp` times the mean over the receiver's
                                       VPLs */
    ISM_NEAR_NONE,                  /* nothing is done: there are bright specks */
    ISM_NEAR_GATHER,                /* near points, squares too, take the place of VPLs within their reach,
                                       and fade in smoothly */
    ISM_NEAR_COUNT
} ism_near;

typedef void (*ism_visible_fn)(void *user, const float position[3], const float geometric_normal[3],
                               const uint32_t *numbers, size_t count, float *visible);
/* A function of yours, such as a ray tracer's, that writes how much of each light a receiver sees. Several
   threads of parallel_for may call the function at once.
   numbers   which lights are asked for: indices of ism_vpls, or of ism_near_points
   visible   count floats, 0..1 */

struct ism_shading {                /* zero it, then set what you care about */
    uint32_t       interleave;      /* 1, 2, 4, 8: every pixel takes 1 / interleave^2 of the VPLs, and a blur
                                       along surfaces mixes neighbours (section 6.2); 0 = 1. A list of
                                       receivers, which has no neighbours, needs 0 or 1 */
    ism_near       near_mode;
    float          clamp;           /* the bound of ISM_NEAR_CLAMP, 1/m^2, and the factor of
                                       ISM_NEAR_CLAMP_MEAN; 0 = 1 */
    float          bias;            /* receivers count as nearer to the VPL by this share of their distance,
                                       below 1; 0 = 0.02; negative = none */
    int            no_maps;         /* not 0: nothing casts shadows */
    int            cull;            /* not 0: VPLs that face away from a block of 16 x 16 pixels are skipped,
                                       which saves time and changes no picture */
    ism_visible_fn visible_fn;      /* asked in place of the maps, to see VPLs exactly; NULL = the maps */
    void          *visible_user;
    ism_visible_fn near_visible_fn; /* the same for near points; NULL: a near point is seen as its VPL is, by
                                       visible_fn or by the maps */
    void          *near_visible_user;
};

struct ism_stats {                  /* of the last run of each stage */
    uint32_t vpls;                  /* VPLs in use: N at most, none if all sources are black */
    uint32_t jumped;                /* VPLs that moved farther than a texel since the last frame */
    uint64_t bad_pvpls;             /* texels that are never chosen, since their flux, place, normal or lobe
                                       is not finite or out of range, or a unit vector is 0 0 0 */
    uint64_t skipped_triangles;     /* triangles with a vertex that is not finite, or without area */
    uint64_t surfels, renewed;      /* all surfels, and those that this frame made anew */
    uint64_t splats;                /* surfels that were drawn into tiles */
    uint64_t wide_splats;           /* those of `splats` whose disc was made smaller, since it would have been
                                       wider than its distance */
    uint64_t filled;                /* texels that pull and push wrote */
    double   surface_area;          /* of the mesh, m^2 */
    double   flux[3];               /* r, g, b of all sources that are surfaces, W */
    double   lost_energy;           /* share of the light that the rule for near VPLs took off, as the mean of
                                       all channels. PATCH counts the light that would have leaked through
                                       bent sheets, too */
    double   culled;                /* share of the pairs of a VPL and a block that culling skipped */
    size_t   bytes, peak_bytes;     /* memory asked of the allocator: now, and the most at once, which in
                                       ism_shade includes the call's own */
    uint32_t near_points;           /* near points of the last ism_choose; 0 after ism_set_vpls */
};

/* ==== src/ism/api_stages.h ==== */

/* ---- stage by stage: what ism_render does ---- */

ISM_DEF ism_result ism_choose(ism_maps *maps, const ism_frame *frame);
/* Chooses VPLs among the texels of the frame's sources, by importance (section 4): VPL i is drawn where the
   running sum of all importances reaches (i + 0.5) / N of the whole. Black sources give no VPLs, which is no
   error.
   Errors   ISM_ERR_ARGUMENT: maps, which leaves no log, or another pointer is NULL, or a count, width or
            stride is out of range.
            ISM_ERR_INPUT: a vector is not unit, a source has no such kind, points have no such rows, or
            world_to_clip is not finite.
            ISM_ERR_LIMIT: all sources together have more than 2^26 texels, or there are more than 2^28
            receivers.
            ISM_ERR_ALLOC: there is no memory.
            ISM_ERR_CANCELLED: VPLs must be chosen anew. */

ISM_DEF ism_result ism_build(ism_maps *maps, const ism_frame *frame);
/* Renews surfels (section 5) and draws the depth maps of all VPLs (sections 3.3, 6.1). Surfels are kept as
   barycentric coordinates on numbered triangles: those that are not renewed follow the mesh. Let what comes
   and goes stand last: surfels on triangles that are gone are renewed at once, and new triangles get theirs
   within lazy_frames. Before a mesh with other numbers, build once without a mesh: all are made anew then.
   Errors   ISM_ERR_ARGUMENT: maps, which leaves no log, or another pointer is NULL, a count, width or stride
            is out of range, or the mesh has both kinds of indices.
            ISM_ERR_ORDER: ism_choose or ism_set_vpls must come first.
            ISM_ERR_INPUT: an index is not below vertex_count, an opacity is beyond 0..1, a receiver's vector
            is not unit, points have no such rows, or world_to_clip is not finite.
            ISM_ERR_LIMIT: the mesh has 2^31 triangles or more, or there are more than 2^28 receivers.
            ISM_ERR_ALLOC: there is no memory.
            ISM_ERR_CANCELLED: maps must be drawn anew.
   Cost     O(triangles + surfels of all VPLs x texels of their discs) */

ISM_DEF ism_result ism_shade(const ism_maps *maps, const ism_points *points, const ism_shading *shading,
                             float *out, ism_stats *stats);
/* Lights receivers, those of the frame or any others, by all VPLs. shading, out and stats are as in
   ism_render; stats->peak_bytes counts what the call allocates while it runs.
   Errors   ISM_ERR_ARGUMENT: maps, which leaves no log, or another pointer is NULL, or a count, width or
            stride is out of range.
            ISM_ERR_DESC: a field of shading is out of range.
            ISM_ERR_ORDER: ism_choose and ism_build must come first. Without ism_build, shading.no_maps or
            shading.visible_fn must be set.
            ISM_ERR_INPUT: a vector is not unit, points have no such rows, or world_to_clip is not finite.
            ISM_ERR_LIMIT: size_t cannot count the memory, or there are more than 2^28 receivers.
            ISM_ERR_ALLOC: there is no memory.
            ISM_ERR_CANCELLED: progress asked for it. */

/* ---- VPLs: to look at, to upload, or of your own ---- */

typedef struct ism_vpl {            /* a virtual point light */
    float    position[3];           /* of directions: the unit direction to the light */
    float    normal[3];             /* unit; of directions: away from the light */
    float    flux[3];               /* r, g, b, W; of directions the irradiance of a surface that faces the
                                       light, W/m^2 */
    float    axis[3], exponent;     /* of the lobe; if the VPL is diffuse, the normal and 1 */
    float    area;                  /* m^2 of surface that the VPL stands for; 0 = estimated from the
                                       distances between VPLs */
    float    edge;                  /* m, of the square that ISM_NEAR_PATCH takes; set by ism_choose and
                                       ism_set_vpls */
    int32_t  directional;           /* not 0: the VPL is of a source of directions */
    uint32_t source, texel;         /* where the VPL comes from; texel = y * width + x */
    int32_t  jumped;                /* 1: the VPL is farther than a texel from where it was in the last frame.
                                       A VPL of directions, of a scattered source or with no_inter_texel jumps
                                       wherever it moves */
    float    reach;                 /* m: near points light receivers within this distance, and receivers
                                       within 0.7 of it take all light from them. 0 = the VPL has none; set by
                                       ism_choose and ism_set_vpls */
    uint32_t window;                /* which part of the square the VPL's tile shows, see ism_zoom; set by
                                       ism_build and ism_scatter */
} ism_vpl;

ISM_DEF const ism_vpl *ism_vpls(const ism_maps *maps, size_t *count);
/* Returns the VPLs and writes how many there are. The array is valid until the next stage. If maps is NULL,
   the array is, too, and the count is 0. count may be NULL. */

ISM_DEF ism_result ism_set_vpls(ism_maps *maps, const ism_vpl *vpls, size_t count);
/* Takes a list of yours in place of ism_choose. There are no near points then.
   vpls     positions must be finite, flux 0..1e30, normal and axis unit, exponent 0..1e5, area finite and not
            negative; edge, reach and window are not read
   Errors   ISM_ERR_ARGUMENT: maps, which leaves no log, or vpls is NULL.
            ISM_ERR_INPUT: a field of a VPL is out of range.
            ISM_ERR_LIMIT: count is above desc.vpl_count.
            ISM_ERR_CANCELLED: VPLs must be chosen anew. */

#ifndef ISM_WITHOUT_SOURCES
ISM_DEF ism_result ism_set_sources(ism_maps *maps, const ism_source *sources, size_t source_count);
/* Takes every point of the sources, in their order, as a VPL in place of ism_choose: VPL i is point i of all,
   so that the numbers of a list of lights, such as rsm_pixel_lights of rsm.h writes, are those of the VPLs.
   There are no near points then. Points without flux keep their number and give no light.
   Errors   ISM_ERR_ARGUMENT: maps, which leaves no log, or another pointer is NULL, or a count or stride is
            out of range.
            ISM_ERR_INPUT: a source has no such kind, or a position, flux, normal or lobe is out of range.
            ISM_ERR_LIMIT: there are more than desc.vpl_count points.
            ISM_ERR_CANCELLED: VPLs must be chosen anew. */
#endif

#ifndef ISM_WITHOUT_NEAR_POINTS
typedef struct ism_near_point {     /* 48 bytes, which gl_ism.h uploads as they are */
    float position[3];
    float edge;                     /* m, of the square that the point becomes */
    float normal[3];
    float reach;                    /* m, as a VPL's */
    float flux[3];                  /* W */
    float vpl;                      /* index of the nearest VPL: its map says which receivers see the point */
} ism_near_point;

ISM_DEF const ism_near_point *ism_near_points(const ism_maps *maps, size_t *count);
/* Returns the near points and writes how many there are: a second, finer choice by the same importances,
   near_point_count times as many as VPLs, among surfaces without lobes. A receiver at distance d takes near
   points with the weight h = 2 - 2 d^2 / reach^2, limited to 0..1, and VPLs with 1 - h, so that close to few
   VPLs the receiver gets the light of many points. Each 64 points in a row are neighbours in space. There are
   no near points (the array is NULL) if fewer than 9 VPLs lie on such surfaces, or after ism_set_vpls. The
   array is valid until the next ism_choose or ism_set_vpls. */
#endif

ISM_DEF const float *ism_importances(const ism_maps *maps, size_t source, size_t *count);
/* Returns the importances of a source's texels (its bidirectional reflective shadow map) as ism_choose left
   them, and how many to count, if that is not NULL. Returns NULL without such a source or a choice. */

#ifndef ISM_WITHOUT_SURFELS
/* ---- surfels: for those who draw the maps themselves, as gl_ism.h does ---- */

ISM_DEF ism_result ism_scatter(ism_maps *maps, const ism_frame *frame);
/* Does the first half of ism_build: makes surfels and windows, but draws no maps.
   Errors   those of ism_build. */

typedef struct ism_surfel {         /* 16 bytes, which gl_ism.h uploads as they are */
    uint32_t triangle;              /* number of the triangle on which the surfel lies */
    float    barycentric[2];        /* weights of the triangle's second and third corner */
    float    area;                  /* area that the surfel stands for, as a share of its triangle's */
} ism_surfel;

ISM_DEF ism_result ism_surfels(const ism_maps *maps, uint32_t vpl, ism_surfel *out, size_t capacity,
                               size_t *count);
/* Writes the surfels of one VPL.
   vpl      below desc.vpl_count
   out      room for capacity surfels; may be NULL if capacity is 0
   count    how many the VPL has, of which capacity are written at most
   Errors   ISM_ERR_ARGUMENT: maps, which leaves no log, or another pointer is NULL, or vpl is too large.
            ISM_ERR_ORDER: there are no surfels; ism_build or ism_scatter must come first, with a mesh. */

ISM_DEF ism_result ism_phase_surfels(const ism_maps *maps, uint32_t phase, ism_surfel *out, size_t capacity,
                                     size_t *count);
/* Writes the surfels of one phase: of every VPL in turn those numbered phase, phase + lazy_frames, phase + 2
   lazy_frames and so on, surfel_count / lazy_frames rounded up of each; surfels that a VPL does not have get
   area 0. A frame renews the phase index % lazy_frames alone: upload this one. Upload all phases after the
   first frame, where the mesh has lost triangles, and with desc.vary_surfels or desc.unstable.
   phase    below lazy_frames
   out      room for capacity surfels; may be NULL if capacity is 0
   count    how many surfels the phase has, of which capacity are written at most
   Errors   ISM_ERR_ARGUMENT: maps, which leaves no log, or another pointer is NULL, or phase is too large.
            ISM_ERR_ORDER: there are no surfels; ism_build or ism_scatter must come first, with a mesh. */
#endif

/* ---- maps ---- */

typedef struct ism_info {           /* facts about maps */
    ism_stats stats;                /* of the last ism_choose, ism_build or ism_scatter */
    uint32_t vpl_count;             /* VPLs in use */
    uint32_t near_point_count;      /* near points in use */
    uint32_t surfel_count, tile_side, lazy_frames;  /* as in ism_desc, with defaults in place of zeros */
    float    center[3], radius;     /* the sphere about the mesh of the last ism_build or ism_scatter, which
                                       maps of directions show */
} ism_info;

ISM_DEF void ism_get_info(const ism_maps *maps, ism_info *out);
/* Writes facts about the maps. If maps or out is NULL, nothing is written. */

#define ISM_FAR 1e30f               /* the depth of a texel in which nothing was drawn */

ISM_DEF const float *ism_atlas(const ism_maps *maps, uint32_t *side, uint32_t *tiles_across);
/* Returns side * side depths, a tile for each VPL: the distance from the VPL to the surface in the direction
   of the texel's centre, or ISM_FAR. Depths of directions are z + radius: see "where in a tile a direction
   lies". Tile i lies at column i % tiles_across and row i / tiles_across. Returns NULL before ism_build; side
   and tiles_across may be NULL. */

#ifndef ISM_WITHOUT_VISIBLE
ISM_DEF ism_result ism_visible(const ism_maps *maps, uint32_t vpl, const ism_points *points, float bias,
                               float *visible);
/* Writes for each receiver whether this VPL's map lets light through to it: 1 or 0. Receivers behind the VPL
   get 1, those whose geometric normal points away from the VPL get 0.
   bias     as in ism_shading
   visible  a float for each receiver
   Errors   ISM_ERR_ARGUMENT: maps, which leaves no log, or another pointer is NULL, there is no such VPL,
            bias is not below 1, or a count, width or stride of points is out of range.
            ISM_ERR_ORDER: ism_build must come first.
            ISM_ERR_INPUT: a vector is not unit, points have no such rows, or world_to_clip is not finite.
            ISM_ERR_LIMIT: there are more than 2^28 receivers. */

typedef struct ism_sight {          /* whose maps ism_see asks */
    const ism_maps *maps;
    float           bias;           /* as in ism_shading; below 1 */
} ism_sight;

ISM_DEF void ism_see(void *sight, const float position[3], const float geometric_normal[3],
                     const uint32_t *numbers, size_t count, float *visible);
/* Writes for one receiver whether the maps of these VPLs let light through to it, 1 or 0, as ism_visible
   does. The function is an ism_visible_fn and an rsm_visible_fn of rsm.h: set it there, so that rsm_gather
   has shadows from these maps. Any number of threads may call it at once.
   sight    an ism_sight
   numbers  numbers of VPLs; what is beyond them gets 1. Before ism_build all get 0
   visible  count floats
   Nothing is checked: pointers must not be NULL, and the normal be unit. */
#endif

/* ==== src/ism/api_tools.h ==== */

#ifndef ISM_WITHOUT_SOURCES
/* ---- sources made for you ---- */

ISM_DEF ism_result ism_bounce(const ism_maps *maps, const ism_mesh *mesh, uint32_t side, float *positions,
                              float *normals, float *fluxes);
/* Writes a source of the next bounce: the surfaces that the VPLs' maps show, as imperfect reflective shadow
   maps. Give the source, which is scattered, to other maps. Texels that show nothing, and those of
   directions, have flux 0. desc.keep_hits must be set.
   mesh     that of the last ism_build
   side     texels a side that are taken of every tile, a power of two up to tile_side
   outputs  N * side * side * 3 floats each
   Errors   ISM_ERR_ARGUMENT: maps, which leaves no log, or another pointer is NULL, or side or a count or
            stride of the mesh is out of range.
            ISM_ERR_ORDER: ism_build must come first.
            ISM_ERR_MISMATCH: the maps were made without desc.keep_hits, or the mesh has not as many
            triangles as that of the last ism_build.
            ISM_ERR_INPUT: an index is not below vertex_count.
   Cost     O(N side^2 + triangles), on this thread, without progress */

ISM_DEF ism_result ism_emitter_points(const ism_mesh *mesh, const float *radiances, uint32_t count,
                                      uint32_t seed, const ism_system *system, float *positions,
                                      float *normals, float *fluxes);
/* Writes count points on emissive triangles: more where more power leaves (pi x radiance x area), each with
   an equal share of it. Make the points a scattered source of kind ISM_SOURCE_SURFACE.
   radiances  r, g, b of each triangle, 0..1e30 W/(sr m^2), else the triangle does not emit; the light leaves
              the side from which the triangle's corners are counter-clockwise
   count      above 0
   system     may be NULL
   outputs    count * 3 floats each
   Errors     ISM_ERR_ARGUMENT: a pointer is NULL, a count or stride is out of range, or there are no
              triangles.
              ISM_ERR_DESC: the allocator has one function of two.
              ISM_ERR_INPUT: an index is not below vertex_count, or no triangle emits.
              ISM_ERR_LIMIT: the mesh has 2^31 triangles or more.
              ISM_ERR_ALLOC: there is no memory. */

ISM_DEF ism_result ism_sky_directions(const float *texels, uint32_t width, uint32_t height, float rotation,
                                      float *directions, float *fluxes, uint64_t *bad_texels);
/* Writes a sky, given as a latitude-longitude map, as a source of ISM_SOURCE_DIRECTIONS. The first row of the
   map looks to +Y, its centre to +X, and +Z lies right of the centre.
   texels      radiance, 3 floats each; channels that are not finite or negative count as 0
   rotation    radians about +Y; in a scene with Z up turn the directions yourself
   outputs     width * height * 3 floats each; fluxes are radiance x the texel's exact solid angle
   bad_texels  how many texels had such channels; may be NULL
   Errors      this call has no log.
               ISM_ERR_ARGUMENT: a pointer is NULL, width or height is 0, or rotation is not finite. */
#endif

/* ---- where in a tile a direction lies: to read the atlas in code and shaders of your own ---- */

/* A direction is found in three steps: turn the direction into the VPL's axes, call ism_map_coordinates, and
   give the result to ism_zoom, which writes a place in the tile. ism_unzoom and ism_map_direction go back.
   The axis z is the VPL's normal. With ISM_PROJECTION_LOBE z is the VPL's lobe's axis; but tiles of VPLs with
   exponent 1 are of ISM_PROJECTION_COSINE then, with the normal as z.
   The axes x and y are made of z = (a, b, c) as by Duff et al., JCGT 6(1), 2017: with s = 1 if c >= 0 and
   else -1, and t = -1 / (s + c), x = (1 + s t a^2, s t a b, -s a) and y = (t a b, s + t b^2, -b).
   Tiles of directions are orthographic: a place that lies at (x, y, z) from ism_info.center, in these axes,
   has uv = 0.5 + 0.5 (x, y) / radius and the depth z + radius. */

ISM_DEF void ism_map_direction(ism_projection projection, float exponent, const float uv[2],
                               float direction[3]);
ISM_DEF int ism_map_coordinates(ism_projection projection, float exponent, const float direction[3],
                                float uv[2]);
/* ism_map_direction goes from a place in the unit square to a unit direction about +z; ism_map_coordinates
   goes back and returns 1. ism_map_coordinates returns 0, with uv untouched, for directions at or below the
   horizon (z <= 0). Corners of the PARABOLOID's square give directions below the horizon.
   Nothing is checked: pointers must not be NULL.
   exponent  0..1e5, of the VPL's lobe; read with ISM_PROJECTION_LOBE alone */

#ifndef ISM_WITHOUT_WINDOWS
ISM_DEF void ism_zoom(uint32_t window, uint32_t tile_side, uint32_t rim, const float uv[2], float tile[2]);
ISM_DEF void ism_unzoom(uint32_t window, uint32_t tile_side, uint32_t rim, const float tile[2], float uv[2]);
/* ism_zoom goes from a place in the square to its place in the tile, which is a unit square too; ism_unzoom
   goes back. The window is the part of the square that has all texels of the tile but `rim`; along each axis
   the map is linear below, in and above the window. Results are clamped to 0..1.
   window   ism_vpl.window: how many 64ths of the square lie below the window in u and in v, and above the
            window in u and in v, six bits each from the lowest on; 0 = the tile shows the square evenly
   rim      desc.window_rim, or its default if it is 0
   Pointers must not be NULL, and tile_side and rim be those of the maps: neither is checked. */
#endif

#ifdef __cplusplus
}
#endif

#endif /* ISM_H */

/* ==== src/ism/begin.h ==== */

/* ==== implementation ================================================================================== */

#if defined(ISM_IMPLEMENTATION) && !defined(ISM_IMPLEMENTED)

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* This file includes itself by this name, to compile its kernels once more for AVX2 and for AVX-512. If you
   renamed the file, define ISM_FILE. */
#ifndef ISM_FILE
#define ISM_FILE "ism.h"
#endif
#define ISM__FILE ISM_FILE

#ifdef ISM_NO_SIMD
#define ISM__NO_SIMD
#endif

/* ==== src/shared/fp_begin.h ==== */

/* unit fp_begin: the arithmetic that the bytes depend on, from here to unit fp_end */

/* Forbids fused multiply-adds that the source does not ask for: gcc fuses across statements in its gnu modes
   and on s390x, clang within expressions. For gcc, the pragmas take a user's -ffast-math back. In clang,
   -ffast-math and -ffp-contract=fast win over the pragma: results then stay within tolerance, but are not
   equal to the bit. */
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#define ISM__FINITE_MATH 1
#else
#define ISM__FINITE_MATH 0
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

typedef struct ism__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} ism__allocator;

static inline void *ism__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void ism__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
static inline int ism__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

static inline int ism__add_size(size_t a, size_t b, size_t *out)
{
    if (a > SIZE_MAX - b) return 0;
    *out = a + b;
    return 1;
}

/* Returns 1 if so many bytes may lie between elements of floats that are `standard` bytes large: 0, which
   stands for `standard`, or a multiple of 4 with which elements do not overlap. */
static inline int ism__stride_valid(size_t stride, size_t standard)
{
    return stride == 0 || (stride >= standard && stride % 4 == 0);
}

/* Returns 1 if the functions of a public allocator are both there or both NULL. */
static inline int ism__allocator_valid(void *(*alloc_fn)(size_t, void *), void (*free_fn)(void *, void *))
{
    return (alloc_fn == NULL) == (free_fn == NULL);
}

static inline ism__allocator ism__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    ism__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : ism__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : ism__default_free;
    a.user = user;
    return a;
}

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *ism__alloc(const ism__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *ism__alloc_array(const ism__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return ism__mul_size(count, item_size, &size) ? ism__alloc(a, size) : NULL;
}

static inline void ism__free(const ism__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/v3.h ==== */

/* unit v3: three floats */

/* tcc 0.9.27 stores a returned struct of 12 bytes as 16, over the caller's next variable. */
typedef struct ism__v3 {
    float x, y, z;
#ifdef __TINYC__
    float unused;
#endif
} ism__v3;

static inline ism__v3 ism__v3_make(float x, float y, float z)
{
    ism__v3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

static inline ism__v3 ism__v3_load(const float *p) { return ism__v3_make(p[0], p[1], p[2]); }
static inline void ism__v3_store(float *p, ism__v3 v) { p[0] = v.x; p[1] = v.y; p[2] = v.z; }

static inline ism__v3 ism__v3_add(ism__v3 a, ism__v3 b)
{
    return ism__v3_make(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline ism__v3 ism__v3_sub(ism__v3 a, ism__v3 b)
{
    return ism__v3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline ism__v3 ism__v3_scale(ism__v3 a, float s)
{
    return ism__v3_make(a.x * s, a.y * s, a.z * s);
}

/* Returns a + b s. */
static inline ism__v3 ism__v3_madd(ism__v3 a, ism__v3 b, float s)
{
    return ism__v3_make(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s);
}

static inline float ism__v3_dot(ism__v3 a, ism__v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float ism__v3_length(ism__v3 a)
{
    return sqrtf(ism__v3_dot(a, a));
}

static inline ism__v3 ism__v3_cross(ism__v3 a, ism__v3 b)
{
    return ism__v3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline ism__v3 ism__v3_min(ism__v3 a, ism__v3 b)
{
    return ism__v3_make(a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z);
}

static inline ism__v3 ism__v3_max(ism__v3 a, ism__v3 b)
{
    return ism__v3_make(a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z);
}

/* Returns a with length 1. The largest component scales the others first, so that neither tiny nor huge
   vectors leave the range of floats. The zero vector stays zero. */
static inline ism__v3 ism__v3_normalize(ism__v3 a)
{
    float x = fabsf(a.x), y = fabsf(a.y), z = fabsf(a.z), m = x > y ? x : y;
    m = m > z ? m : z;
    if (!(m > 0.0f)) return ism__v3_make(0.0f, 0.0f, 0.0f);
    if (m < 1e-30f) {
        a = ism__v3_scale(a, 1e30f);
        m *= 1e30f;
    }
    a = ism__v3_make(a.x / m, a.y / m, a.z / m);
    m = ism__v3_length(a);
    return ism__v3_make(a.x / m, a.y / m, a.z / m);
}

/* Returns 1 if x is finite, by its exponent bits: under -ffast-math compilers may take isfinite() for always
   true. */
static inline int ism__finite(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7f800000u) != 0x7f800000u;
}

static inline int ism__in(float x, float low, float high) { return ism__finite(x) && x >= low && x <= high; }

static inline int ism__v3_finite(ism__v3 a)
{
    return ism__finite(a.x) && ism__finite(a.y) && ism__finite(a.z);
}

/* Writes b1 and b2, which are orthonormal and right-handed together with a unit n; n.z may be -0 or -1. Duff
   et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017. */
static inline void ism__v3_basis(ism__v3 n, ism__v3 *b1, ism__v3 *b2)
{
    float s = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + n.z), b = n.x * n.y * a;
    *b1 = ism__v3_make(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
    *b2 = ism__v3_make(b, s + n.y * n.y * a, -n.y);
}

/* ==== src/shared/unit.h ==== */

/* unit unit: which vectors count as unit, the same in every header (src/README.md, "Unit vectors") */

/* The squares of the least and the greatest length that count as 1: an 8-bit normal map makes such
   vectors. */
#define ISM__UNIT_LEAST2 0.9409f       /* 0.97^2 */
#define ISM__UNIT_MOST2 1.0609f        /* 1.03^2 */

/* Says whether a vector is unit, by the square of its length. If that is not a number, the vector is not. */
static inline int ism__is_unit2(float length2)
{
    return length2 >= ISM__UNIT_LEAST2 && length2 <= ISM__UNIT_MOST2;
}

/* ==== src/shared/trig.h ==== */

/* unit trig: elementary functions with the same bits on every machine */

/* These functions use + - * / and sqrt alone, which IEEE 754 rounds the same everywhere as long as nothing
   is contracted (unit fp_begin). Coefficients are minimax fits of our own. The float functions are free of
   branches and calls, so that loops over them vectorise at SSE2 level. The errors named below are the
   largest differences from the double functions, over all float arguments or a dense set
   (tests/shared/units_test.c). Arguments out of range and NaN are clamped into the range, so that nothing
   here is undefined or returns NaN. */

static inline float ism__from_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline uint32_t ism__to_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* Returns |x| with the sign bit of s; s = -0 counts as negative. */
static inline float ism__copysign(float x, float s)
{
    return ism__from_bits((ism__to_bits(x) & 0x7fffffffu) | (ism__to_bits(s) & 0x80000000u));
}

/* Returns a if yes is 1 and b if it is 0, without a branch: compilers turn a chain of ?: with one condition
   into a branch, and then do not vectorise the loop round it. */
static inline float ism__either(int yes, float a, float b)
{
    uint32_t mask = 0u - (uint32_t)yes;
    return ism__from_bits((ism__to_bits(a) & mask) | (ism__to_bits(b) & ~mask));
}

/* Writes sine and cosine of |x| <= 8192 with an absolute error of 1e-7. As in Cody and Waite, pi/2 has three
   parts, of which the first two times k are exact for |k| < 2^13. */
static inline void ism__sincos(float x, float *sine, float *cosine)
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

/* Returns atan2 with an error of 4e-7, at most 3 ulp. All quadrants, zeros of either sign and infinities are
   as with C's atan2f; atan2(0, 0) is 0. */
static inline float ism__atan2(float y, float x)
{
    float ax = fabsf(x), ay = fabsf(y);
    float a, t, z, p;
    float hi = ism__either(ax > ay, ax, ay), lo = ism__either(ax > ay, ay, ax);
    int big;
    a = ism__either((lo == hi) & (hi > 0.0f), 1.0f, lo / ism__either(hi > 0.0f, hi, 1.0f));
    big = a > 0.414213562f;
    t = ism__either(big, (a - 1.0f) / (a + 1.0f), a);
    z = t * t;
    p = t + t * z * (-0.3333295525f + z * (0.1997792608f + z * (-0.1387984996f + z * 0.08060308882f)));
    p = ism__either(big, p + 0.785398163f, p);
    p = ism__either(ay > ax, 1.57079633f - p, p);
    p = ism__either((int)(ism__to_bits(x) >> 31), 3.14159265f - p, p);
    return ism__copysign(p, y);
}

/* Returns exp(x) as 2^k (1 + r + r^2 p(r)) with |r| <= ln 2 / 2, in double, so that exp, log and pow err by
   1 ulp. */
static inline double ism__exp_core(double x)
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
static inline double ism__log_core(float x)
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
static inline float ism__exp(float x)
{
    return x > 88.7228394f ? ism__from_bits(0x7f800000u) : (float)ism__exp_core((double)x);
}

/* Returns the natural logarithm of x, or -infinity if x is not above 0. */
static inline float ism__log(float x)
{
    return x > 0.0f ? (float)ism__log_core(x) : ism__from_bits(0xff800000u);
}

/* Returns x^y. x below 0 counts as 0; 0^y is 0, 1 or infinity for y above, equal to or below 0. */
static inline float ism__pow(float x, float y)
{
    double t;
    if (y == 0.0f) return 1.0f;
    if (!(x > 0.0f)) return y > 0.0f ? 0.0f : ism__from_bits(0x7f800000u);
    t = (double)y * ism__log_core(x);
    return t > 88.722839111 ? ism__from_bits(0x7f800000u) : (float)ism__exp_core(t);
}

/* ==== src/shared/rng.h ==== */

/* unit rng: hashes and random numbers, the same on every machine */

/* Returns a hash by the output function of O'Neill's PCG: Jarzynski and Olano, "Hash functions for GPU
   rendering", JCGT 9(3), 2020. */
static inline uint32_t ism__hash32(uint32_t x)
{
    uint32_t state = x * 747796405u + 2891336453u;
    uint32_t word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

static inline uint32_t ism__hash_combine(uint32_t a, uint32_t b)
{
    return ism__hash32(a + 0x9e3779b9u * ism__hash32(b));
}

/* Returns the upper 24 bits as a number in [0, 1). Every such value is a float; the largest is 1 - 2^-24. */
static inline float ism__to_unit(uint32_t bits) { return (float)(bits >> 8) * (1.0f / 16777216.0f); }

/* ==== src/shared/cdf.h ==== */

/* unit cdf: piecewise-constant distributions in 1D and 2D, sampled by inversion */

/* A distribution over cells. sums[i] is the sum of the weights before cell i and sums[count] that of all;
   the array is the caller's. Sums are double, since a float sum of 1e6 small weights is wrong in the third
   digit. */
typedef struct ism__cdf { const double *sums; uint32_t count; } ism__cdf;

typedef struct ism__cdf_sample {
    uint32_t index;
    float    fraction;      /* where u fell inside the cell, [0, 1): a fresh random number */
    float    probability;   /* of the cell; 0 only if all weights are 0 */
} ism__cdf_sample;

/* Makes a distribution of weights, each times `scale`, which is 1 for most callers. Negative, NaN and
   infinite weights count as 0; their number is returned. */
static inline size_t ism__cdf_build(ism__cdf *cdf, double *sums, const float *weights, uint32_t count, double scale)
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

static inline double ism__cdf_total(const ism__cdf *cdf) { return cdf->sums[cdf->count]; }

/* Returns the cell i with sums[i] <= u * total < sums[i + 1]. The strict upper bound keeps empty cells out,
   even at u = 0, and keeps the index in range for u below 1. u outside [0, 1) is clamped. */
static inline ism__cdf_sample ism__cdf_sample_at(const ism__cdf *cdf, float u)
{
    ism__cdf_sample s;
    double total = ism__cdf_total(cdf), x, width, f;
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

/* A distribution over the cells of a grid: `rows` is the one over whole rows, `sums` has that of each row. */
typedef struct ism__cdf2 { const double *rows, *sums; uint32_t width, height; } ism__cdf2;

typedef struct ism__cdf2_sample {
    uint32_t x, y;
    float    fx, fy;        /* inside the cell, [0, 1) */
    float    probability;   /* of the cell */
} ism__cdf2_sample;

/* Returns how many doubles a distribution over width * height cells needs; 0 if their size overflows. */
static inline size_t ism__cdf2_doubles(uint32_t width, uint32_t height)
{
    size_t row = (size_t)width + 1u, rows = (size_t)height + 1u;
    if (row == 0 || rows == 0 || height > (SIZE_MAX / sizeof(double) - rows) / row) return 0;
    return row * height + rows;
}

/* Makes a distribution of weights that are given row by row. row_scale, NULL for 1, multiplies whole rows,
   as the solid angle of the rows of a latitude-longitude map does. Returns the number of bad weights, as
   ism__cdf_build. */
static inline size_t ism__cdf2_build(ism__cdf2 *cdf, double *memory, const float *weights, const float *row_scale,
                                  uint32_t width, uint32_t height)
{
    double *rows = memory, *sums = memory + height + 1u, total = 0.0;
    size_t bad = 0;
    uint32_t y;

    for (y = 0; y < height; y++) {
        ism__cdf row;
        bad += ism__cdf_build(&row, sums + (size_t)y * (width + 1u), weights + (size_t)y * width, width,
                           row_scale ? (double)row_scale[y] : 1.0);
        rows[y] = total;
        total += ism__cdf_total(&row);
    }
    rows[height] = total;
    cdf->rows = rows;
    cdf->sums = sums;
    cdf->width = width;
    cdf->height = height;
    return bad;
}

static inline ism__cdf ism__cdf2_row(const ism__cdf2 *cdf, uint32_t y)
{
    ism__cdf row;
    row.sums = cdf->sums + (size_t)y * (cdf->width + 1u);
    row.count = cdf->width;
    return row;
}

static inline double ism__cdf2_total(const ism__cdf2 *cdf) { return cdf->rows[cdf->height]; }

static inline float ism__cdf2_probability(const ism__cdf2 *cdf, uint32_t x, uint32_t y)
{
    const double *row = cdf->sums + (size_t)y * (cdf->width + 1u);
    double total = ism__cdf2_total(cdf);
    return total > 0.0 ? (float)((row[x + 1u] - row[x]) / total) : 0.0f;
}

static inline ism__cdf2_sample ism__cdf2_sample_at(const ism__cdf2 *cdf, float u, float v)
{
    ism__cdf marginal, row;
    ism__cdf_sample sx, sy;
    ism__cdf2_sample s;

    marginal.sums = cdf->rows;
    marginal.count = cdf->height;
    sy = ism__cdf_sample_at(&marginal, v);
    row = ism__cdf2_row(cdf, sy.index);
    sx = ism__cdf_sample_at(&row, u);
    s.x = sx.index;
    s.y = sy.index;
    s.fx = sx.fraction;
    s.fy = sy.fraction;
    s.probability = ism__cdf2_probability(cdf, s.x, s.y);
    return s;
}

/* ==== src/shared/cpu.h ==== */

/* unit cpu: run-time detection of x86 vector units */

/* ISM__X86 is 1 if functions with target attributes can be compiled and chosen at run time. ISM__NO_SIMD, which
   the header defines from its public switch, makes it 0. tcc has no such attributes, so that it is 0 there;
   MSVC needs none. For clang in MSVC's place (clang-cl) it is 0, since this compiler hides the vector types
   unless the whole program is built for them. */
#if defined(ISM__NO_SIMD) || defined(__TINYC__)
#define ISM__X86 0
#elif defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
#define ISM__X86 1
#define ISM__TARGET_AVX2 __attribute__((target("avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#define ISM__TARGET_AVX512 \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#elif defined(_MSC_VER) && defined(_M_X64) && !defined(__clang__)
#define ISM__X86 1
#define ISM__TARGET_AVX2
#define ISM__TARGET_AVX512
#else
#define ISM__X86 0
#endif

/* These ask the processor directly: the compilers' own functions ask the same, but add 4.5 KB to every
   program. */
#if ISM__X86 && defined(_MSC_VER)
#include <intrin.h>
static inline void ism__cpu_ask(unsigned leaf, unsigned *r) { __cpuidex((int *)r, (int)leaf, 0); }
static inline unsigned ism__cpu_xcr0(void) { return (unsigned)_xgetbv(0); }
#elif ISM__X86
#include <cpuid.h>
static inline void ism__cpu_ask(unsigned leaf, unsigned *r)
{
    __cpuid_count(leaf, 0, r[0], r[1], r[2], r[3]);
}
static inline unsigned ism__cpu_xcr0(void)
{
    unsigned low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}
#endif

#if ISM__X86
/* Returns 1 if all of these bits are set in ebx of cpuid's leaf 7, the processor has FMA and POPCNT, and the
   operating system saves the registers that the bits of xcr0 stand for. Every processor with BMI2 has
   LZCNT. */
static inline int ism__cpu_leaf7(unsigned xcr0, unsigned ebx)
{
    const unsigned wanted = 1u << 12 | 1u << 23 | 1u << 27;     /* FMA, POPCNT, OSXSAVE */
    unsigned r[4];
    ism__cpu_ask(0, r);
    if (r[0] < 7) return 0;
    ism__cpu_ask(1, r);
    if ((r[2] & wanted) != wanted || (ism__cpu_xcr0() & xcr0) != xcr0) return 0;
    ism__cpu_ask(7, r);
    return (r[1] & ebx) == ebx;
}
/* Asks for AVX2, BMI and BMI2, and for the registers of SSE and AVX. */
static inline int ism__cpu_has_avx2(void) { return ism__cpu_leaf7(0x06u, 0x00000128u); }
/* Asks for F, DQ, BW and VL of AVX-512 besides, and for its mask registers and wide registers. */
static inline int ism__cpu_has_avx512(void) { return ism__cpu_leaf7(0xe6u, 0xc0030128u); }
#else
static inline int ism__cpu_has_avx2(void) { return 0; }
static inline int ism__cpu_has_avx512(void) { return 0; }
#endif

/* ==== src/shared/part.h ==== */

/* unit part: the caller's progress within parts of a call, and whether it cancels */

/* The share from..to of a call's progress, 0..1. progress may be NULL. */
typedef struct ism__part {
    int (*progress)(void *user, float fraction);
    void *user;
    float from, to;
} ism__part;

/* Tells the caller that this fraction of the part is done. Returns not 0 if the caller cancels. progress
   must not be NULL. */
static inline int ism__part_tell(const ism__part *p, float fraction)
{
    return p->progress(p->user, p->from + (p->to - p->from) * fraction);
}

static inline ism__part ism__part_of(const ism__part *whole, float from, float to)
{
    ism__part p = *whole;
    p.from = whole->from + (whole->to - whole->from) * from;
    p.to = whole->from + (whole->to - whole->from) * to;
    return p;
}

/* Returns 1 if the caller cancels before step i of count; the caller is asked every so many steps. */
static inline int ism__cancelled(const ism__part *p, size_t i, size_t count, size_t every)
{
    return p->progress && i % every == 0 && ism__part_tell(p, (float)((double)i / (double)count)) != 0;
}

/* ==== src/shared/batch.h ==== */

/* unit batch: tasks of a call, some at a time */

typedef struct ism__batch { void (*task)(void *context, size_t index); void *context; size_t first; } ism__batch;

/* The task of a batch, with the batch as its context. */
static inline void ism__batch_task(void *context, size_t index)
{
    const ism__batch *b = (const ism__batch *)context;
    b->task(b->context, b->first + index);
}

/* ==== src/shared/hot.h ==== */

/* unit hot, needs fp_begin: attributes of functions that take most of the time */

/* ISM__INLINE stands before what must be inlined into kernels of several targets. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define ISM__INLINE static inline __attribute__((always_inline))
#elif defined(_MSC_VER)
#define ISM__INLINE static __forceinline
#else
#define ISM__INLINE static inline
#endif

#if defined(__GNUC__) && !defined(__TINYC__)
#define ISM__PREFETCH(p) __builtin_prefetch(p)
#else
#define ISM__PREFETCH(p) (void)(p)
#endif

/* ==== src/shared/simd.h ==== */

/* unit simd, needs cpu: one text of a kernel for every instruction set */

/* A kernel is written once, for ism__lanes: ISM__LANE_COUNT floats, of which the instruction set ISM__SET
   computes ISM__WIDTH at a time. What lies between unit simd_begin and the last kernel of a header is compiled
   once for every set that the program may meet. It is first compiled in its place, as set "plain", for what
   the whole program is compiled for (SSE2, NEON, the 128 bits of WebAssembly, or one float at a time). Then,
   if ISM__SIMD_SETS is 1, the header includes itself with ISM__SET, ISM__WIDTH and ISM__LANE_COUNT defined
   anew: avx2 with 8 lanes, avx512 with 16. ism__simd_level returns which set to call. With ISM__NO_SIMD there
   are no intrinsics; the compiler's own vectors, which are portable, stay if ISM__COMPILER_VECTORS is
   defined. ISM__FILE is the header's name; a header pasted into another file cannot include itself: "plain".

   What is compiled several times needs a name for each set. The list below makes ism__lanes_add the name
   ism__lanes_add_avx2 in set avx2; the header has such a list for its kernels. ISM__KERNEL stands before a
   kernel, ISM__IN_KERNEL before what is inlined into kernels.

   Every set gives the same bits, but for ism__lanes_muladd, which rounds once in avx2 and avx512, twice
   elsewhere. */
#if defined(ISM__NO_SIMD) && (!defined(ISM__COMPILER_VECTORS) || defined(__i386__))
#define ISM__SCALAR 1
#else
#define ISM__SCALAR 0
#endif
#if ISM__X86
#include <immintrin.h>
#define ISM__SIMD_SETS 1
#else
#define ISM__SIMD_SETS 0
#endif
#if ISM__X86 && (defined(__x86_64__) || defined(_M_X64))
#define ISM__SIMD_X86 1
#define ISM__SIMD_VECTORS 0
#define ISM__SIMD_WIDTH 4
#elif !ISM__X86 && !ISM__SCALAR && (defined(__GNUC__) || defined(__clang__)) && !defined(__TINYC__)
#define ISM__SIMD_X86 0
#define ISM__SIMD_VECTORS 1
#define ISM__SIMD_WIDTH 4
#else
#define ISM__SIMD_X86 0
#define ISM__SIMD_VECTORS 0
#define ISM__SIMD_WIDTH 1
#endif
#ifdef __has_include
#if !__has_include(ISM__FILE)
#undef ISM__SIMD_SETS
#define ISM__SIMD_SETS 0
#endif
#endif
#if ISM__SIMD_VECTORS && defined(__aarch64__) && !defined(ISM__NO_SIMD)
#include <arm_neon.h>
#elif ISM__SIMD_VECTORS && defined(__wasm_simd128__) && !defined(ISM__NO_SIMD)
#include <wasm_simd128.h>
#endif

#define ISM__NAME_OF_SET(name, set) name##_##set
#define ISM__NAME_IN_SET(name, set) ISM__NAME_OF_SET(name, set)
#define ism__lanes ISM__NAME_IN_SET(ism__lanes, ISM__SET)
#define ism__lane_mask ISM__NAME_IN_SET(ism__lane_mask, ISM__SET)
#define ism__lane_ints ISM__NAME_IN_SET(ism__lane_ints, ISM__SET)
#define ism__piece ISM__NAME_IN_SET(ism__piece, ISM__SET)
#define ism__piece_ints ISM__NAME_IN_SET(ism__piece_ints, ISM__SET)
#define ism__piece_words ISM__NAME_IN_SET(ism__piece_words, ISM__SET)
#define ism__lanes_load ISM__NAME_IN_SET(ism__lanes_load, ISM__SET)
#define ism__lanes_store ISM__NAME_IN_SET(ism__lanes_store, ISM__SET)
#define ism__lanes_all ISM__NAME_IN_SET(ism__lanes_all, ISM__SET)
#define ism__lanes_add ISM__NAME_IN_SET(ism__lanes_add, ISM__SET)
#define ism__lanes_sub ISM__NAME_IN_SET(ism__lanes_sub, ISM__SET)
#define ism__lanes_mul ISM__NAME_IN_SET(ism__lanes_mul, ISM__SET)
#define ism__lanes_div ISM__NAME_IN_SET(ism__lanes_div, ISM__SET)
#define ism__lanes_max ISM__NAME_IN_SET(ism__lanes_max, ISM__SET)
#define ism__lanes_min ISM__NAME_IN_SET(ism__lanes_min, ISM__SET)
#define ism__lanes_sqrt ISM__NAME_IN_SET(ism__lanes_sqrt, ISM__SET)
#define ism__lanes_abs ISM__NAME_IN_SET(ism__lanes_abs, ISM__SET)
#define ism__lanes_negate ISM__NAME_IN_SET(ism__lanes_negate, ISM__SET)
#define ism__lanes_greater ISM__NAME_IN_SET(ism__lanes_greater, ISM__SET)
#define ism__lanes_at_least ISM__NAME_IN_SET(ism__lanes_at_least, ISM__SET)
#define ism__lanes_select ISM__NAME_IN_SET(ism__lanes_select, ISM__SET)
#define ism__lanes_keep ISM__NAME_IN_SET(ism__lanes_keep, ISM__SET)
#define ism__lanes_truncate ISM__NAME_IN_SET(ism__lanes_truncate, ISM__SET)
#define ism__lanes3 ISM__NAME_IN_SET(ism__lanes3, ISM__SET)
#define ism__lanes3_load ISM__NAME_IN_SET(ism__lanes3_load, ISM__SET)
#define ism__lanes3_all ISM__NAME_IN_SET(ism__lanes3_all, ISM__SET)
#define ism__lanes3_scale ISM__NAME_IN_SET(ism__lanes3_scale, ISM__SET)
#define ism__lanes3_sub ISM__NAME_IN_SET(ism__lanes3_sub, ISM__SET)
#define ism__lanes3_dot ISM__NAME_IN_SET(ism__lanes3_dot, ISM__SET)
#define ism__mask_and ISM__NAME_IN_SET(ism__mask_and, ISM__SET)
#define ism__mask_bits ISM__NAME_IN_SET(ism__mask_bits, ISM__SET)
#define ism__mask_of_bits ISM__NAME_IN_SET(ism__mask_of_bits, ISM__SET)
#define ism__ints_store ISM__NAME_IN_SET(ism__ints_store, ISM__SET)

/* Returns 2 if AVX-512 may be used, 1 if AVX2 may be, otherwise 0. */
static inline int ism__simd_level(void)
{
    if (!ISM__SIMD_SETS || !ism__cpu_has_avx2()) return 0;
    return ism__cpu_has_avx512() ? 2 : 1;
}

/* ==== src/shared/bits.h ==== */

/* unit bits: counting and finding bits */

/* Returns how many bits of x are set. */
static inline uint32_t ism__popcount(uint64_t x)
{
    x -= x >> 1 & 0x5555555555555555u;
    x = (x & 0x3333333333333333u) + (x >> 2 & 0x3333333333333333u);
    x = (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    return (uint32_t)(x * 0x0101010101010101u >> 56);
}

/* ==== src/shared/message.h ==== */

/* unit message: one line for the caller's log that says why a call failed */

/* ISM__COLD stands before functions that are needed only by calls that fail: compilers make these functions
   small, and take branches to them for unlikely. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define ISM__COLD __attribute__((cold))
#else
#define ISM__COLD
#endif

/* Where a message goes, and the name of the function that failed. If log is NULL, nothing is written. */
typedef struct ism__logger {
    void (*log)(void *user, const char *message);
    void *user;
    const char *function;
} ism__logger;

typedef struct ism__message { char text[256]; size_t used; } ism__message;

/* Appends a text; what does not fit is cut off. */
static inline ISM__COLD void ism__message_text(ism__message *m, const char *s)
{
    while (*s && m->used + 1 < sizeof m->text) m->text[m->used++] = *s++;
    m->text[m->used] = 0;
}

static inline ISM__COLD void ism__message_count(ism__message *m, uint64_t value)
{
    char digits[24];
    size_t at = sizeof digits - 1;
    digits[at] = 0;
    do digits[--at] = (char)('0' + (int)(value % 10));
    while ((value /= 10) != 0);
    ism__message_text(m, digits + at);
}

/* Writes six significant digits without the zeros at their end. Returns how many digits are left and writes
   *exponent, the power of ten of the first one. value is finite and above 0. */
static inline ISM__COLD int ism__message_digits(double value, char digits[8], int *exponent)
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
static inline ISM__COLD void ism__message_number(ism__message *m, double value)
{
    char digits[8], first[2] = { 0, 0 };
    int exponent, count, i;

    if (value != value) {
        ism__message_text(m, "not a number");
        return;
    }
    if (value < 0.0) ism__message_text(m, "-");
    if (value < 0.0) value = -value;
    if (!(value > 0.0) || value > 1.7976931348623157e308) {
        ism__message_text(m, value > 0.0 ? "infinity" : "0");
        return;
    }
    if (value < 9007199254740992.0 && value - (double)(uint64_t)value <= 0.0) {
        ism__message_count(m, (uint64_t)value);
        return;
    }
    count = ism__message_digits(value, digits, &exponent);
    first[0] = digits[0];
    if (exponent < -4 || exponent > 9) {
        ism__message_text(m, first);
        if (count > 1) ism__message_text(m, ".");
        ism__message_text(m, digits + 1);
        ism__message_text(m, exponent < 0 ? "e-" : "e");
        ism__message_count(m, (uint64_t)(exponent < 0 ? -exponent : exponent));
        return;
    }
    if (exponent < 0) ism__message_text(m, "0.");
    for (i = exponent; i < -1; i++) ism__message_text(m, "0");
    for (i = 0; i < count; i++) {
        if (exponent >= 0 && i == exponent + 1) ism__message_text(m, ".");
        first[0] = digits[i];
        ism__message_text(m, first);
    }
    for (i = count; i <= exponent; i++) ism__message_text(m, "0");
}

/* Begins a line: "FUNCTION: FIELD". */
static inline ISM__COLD void ism__message_begin(ism__message *m,
                                          const ism__logger *logger, const char *field)
{
    m->used = 0;
    ism__message_text(m, logger->function);
    ism__message_text(m, ": ");
    ism__message_text(m, field);
}

/* Logs "FUNCTION: FIELD TEXT", as in "cohsm_build: mesh.positions is NULL". */
static inline ISM__COLD void ism__log_text(const ism__logger *logger, const char *field, const char *text)
{
    ism__message m;
    if (!logger->log) return;
    ism__message_begin(&m, logger, field);
    ism__message_text(&m, " ");
    ism__message_text(&m, text);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: FIELD is VALUE; it must be WANTED", as in "cohsm_build: desc.map_side is 3; it must be 0 or
   4..1024". */
static inline ISM__COLD void ism__log_value(const ism__logger *logger, const char *field, double value,
                                      const char *wanted)
{
    ism__message m;
    if (!logger->log) return;
    ism__message_begin(&m, logger, field);
    ism__message_text(&m, " is ");
    ism__message_number(&m, value);
    ism__message_text(&m, "; it must be ");
    ism__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: ARRAY[INDEX] WHAT VALUE; it must be WANTED", as in "rsm_gather: normals[17] has the length
   0.5; it must be 1 (0.97..1.03), or 0". */
static inline ISM__COLD void ism__log_element(const ism__logger *logger, const char *array, uint64_t index,
                                        const char *what, double value, const char *wanted)
{
    ism__message m;
    if (!logger->log) return;
    ism__message_begin(&m, logger, array);
    ism__message_text(&m, "[");
    ism__message_count(&m, index);
    ism__message_text(&m, "] ");
    ism__message_text(&m, what);
    ism__message_text(&m, " ");
    ism__message_number(&m, value);
    ism__message_text(&m, "; it must be ");
    ism__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: mesh: index 2 of triangle 17 is 90, but the mesh has 80 vertices". position counts the
   indices from 0. */
static inline ISM__COLD void ism__log_index(const ism__logger *logger, const char *mesh,
                                      uint64_t position, uint64_t index, uint64_t vertex_count)
{
    ism__message m;
    if (!logger->log) return;
    ism__message_begin(&m, logger, mesh);
    ism__message_text(&m, ": index ");
    ism__message_count(&m, position % 3);
    ism__message_text(&m, " of triangle ");
    ism__message_count(&m, position / 3);
    ism__message_text(&m, " is ");
    ism__message_count(&m, index);
    ism__message_text(&m, ", but the mesh has ");
    ism__message_count(&m, vertex_count);
    ism__message_text(&m, vertex_count == 1 ? " vertex" : " vertices");
    logger->log(logger->user, m.text);
}

/* ==== src/ism/state.h ==== */

/* ---- state: what an ism_maps holds, how its memory grows, how its tasks run ---- */

#define ISM__PI 3.14159265f
#define ISM__MAX_FLOAT 3.402823466e38f
/* The square of a disc's radius is at most this, in squares of its distance from the VPL; ISM__WIDEST_BACK is
   for discs that are seen from behind. Discs that are made smaller so are counted in wide_splats. */
#define ISM__WIDEST 1.0f
#define ISM__WIDEST_BACK 0.04f
#define ISM__EITHER 0.05            /* weight of what the view alone, or the VPL alone, sees of a cluster; the
                                       geometric mean of both has the weight 1 */
#define ISM__CUT_SCALE 6.0f         /* area of discs that their triangle cuts off, over that of the others */
#define ISM__EDGE 1e-4f             /* discs reach over their triangle's edge by this much of a barycentric
                                       coordinate, so that no light leaks between triangles */
#define ISM__GRAZING 1e-4f          /* a VPL whose cosine to a receiver's plane is less counts as behind that
                                       plane, since only rounding tells the sides apart */
#define ISM__HOLE 2                 /* texels to each side that are searched for surfels around a hole */
#define ISM__LANES 64u              /* tiles drawn at once at most; each lane has scratch memory of its own */
#define ISM__BLOCK 16u              /* pixels a side of what one task shades */
#define ISM__CHUNK 64u              /* VPLs whose form factors are computed together */
#define ISM__BATCHES 16u            /* calls of progress in a stage */
#define ISM__NEAR_BLOCK 64u         /* near points that lie together */
#define ISM__STEPS 64u              /* the square's side has so many steps, at which windows begin and end */
#define ISM__SLACK 2u               /* a window stays where it was if it reaches no more steps than this
                                       farther out than it must */
#define ISM__SIGHTS 64u             /* blocks of the picture; eight receivers of each make the windows */
#define ISM__PAD 0.015625f          /* share of the extent of those receivers that is added at either side,
                                       since other receivers may lie a little outside */
#define ISM__NEAR_RANK 8u           /* the reach of a near point is twice its distance from the VPL that has
                                       this rank among the nearest */

typedef struct ism__buffer { void *data; size_t size; } ism__buffer;

typedef struct ism__texel {         /* a texel of a tile while the tile is drawn */
    float    g[3];                  /* plane of the surfel: 1 / t = g . direction; in maps of directions t =
                                       g . (x, y, 1) */
    uint32_t triangle, filled;      /* filled: push gave the depth, which is g[0] */
} ism__texel;

typedef struct ism__surfel { uint32_t triangle; uint16_t b1, b2; float weight; } ism__surfel;

typedef struct ism__orientation { ism__v3 x, y, z; } ism__orientation;

/* How one axis of the square is mapped to the tile: the window lo..hi becomes a..b; below, inside and above
   are the slopes in the three parts. If `on` is 0, the map is the identity. */
typedef struct ism__axis { int on; float lo, hi, a, b, below, inside, above; } ism__axis;
typedef struct ism__window { ism__axis u, v; } ism__window;

enum { ISM__DISCS = 16,             /* points that are drawn together */
       ISM__AHEAD = 16 };           /* points whose memory is fetched before it is wanted */

/* What shading reads of a VPL: arrays of one float each, so that compilers vectorise the loop over them. */
enum { ISM__PX, ISM__PY, ISM__PZ, ISM__NX, ISM__NY, ISM__NZ, ISM__FIELDS };

/* Receivers as a picture of width x height; a list is one row. */
typedef struct ism__view { const ism_points *points; uint32_t width, height; } ism__view;

/* The arguments of a public call after they were checked, with its progress and its log. */
typedef struct ism__job {
    const ism_frame *frame;
    ism__view        view;
    ism__part        part;          /* of the caller's progress */
    ism__logger      log;
} ism__job;

struct ism_maps {
    ism_desc        desc;           /* with defaults resolved: near_point_count and window_rim are 0 where
                                       there are none */
    ism__allocator  memory;
    uint32_t        tiles;          /* a side of the atlas */
    uint32_t        side;           /* texels a side of the atlas */
    ism_vpl        *vpls;           /* N; the first vpl_count are in use */
    uint32_t        vpl_count;
    uint32_t        previous_count; /* VPLs of the frame before, for `jumped` */
    int             chosen, built;  /* there are VPLs; there are maps */
    ism__buffer     atlas, hits, scratch, directions;       /* maps, and the memory that drawing them takes */
    ism__buffer     surfels, counts;                        /* points of all VPLs, and how many each has */
    ism__buffer     sums, clusters, shares, weights;        /* distributions from which points are drawn */
    ism__buffer     sources, importance, blurred, cdf;      /* distributions from which VPLs are drawn */
    ism__buffer     previous, windows, pixels;              /* VPLs of the last frame; receivers */
    ism__buffer     near_points, near_blocks, near_drawn, near_keys;
    uint32_t        window_count;   /* VPLs of the frame before, whose ism_vpl.window is kept in `windows`
                                       after the ism__window of each VPL of this frame */
    uint32_t        near_count;     /* near points in use */
    uint32_t        blank_from;     /* tiles of the atlas from this one on show nothing */
    size_t          triangles;      /* triangles that the points lie on; 0 = there are no points yet */
    size_t          source_count, cells;    /* cells: pVPLs of all sources */
    float           center[3], radius;      /* bounding sphere of the mesh, for directions */
    ism_stats       stats;
};

/* Where a source's arrays begin in the buffers importance and cdf; the sum of its fluxes, and of its
   importances. */
typedef struct ism__source_of { size_t first, cdf_first; double flux, total; } ism__source_of;

/* Makes a buffer large enough; its content is lost if it grows. Returns 0 if there is no memory. */
static int ism__grow(ism_maps *m, ism__buffer *b, size_t count, size_t item)
{
    size_t size;
    void *data;
    if (!ism__mul_size(count ? count : 1u, item, &size)) return 0;
    if (size <= b->size) return 1;
    data = ism__alloc(&m->memory, size);
    if (!data) return 0;
    m->stats.bytes += size;
    if (m->stats.bytes > m->stats.peak_bytes) m->stats.peak_bytes = m->stats.bytes;
    ism__free(&m->memory, b->data);
    m->stats.bytes -= b->size;
    b->data = data;
    b->size = size;
    return 1;
}

static void ism__release(ism_maps *m, ism__buffer *b)
{
    ism__free(&m->memory, b->data);
    m->stats.bytes -= b->size;
    b->data = NULL;
    b->size = 0;
}

/* Runs all tasks, in batches between which the caller's progress goes from..to of the part. Returns 0 if the
   caller cancels. */
static int ism__run(const ism_maps *m, const ism__part *part, float from, float to, size_t count,
                    ism_task task, void *context)
{
    const ism_system *system = &m->desc.system;
    size_t batches = part->progress ? (count < ISM__BATCHES ? count : ISM__BATCHES) : 1u, i, k;
    ism__part own = ism__part_of(part, from, to);
    for (i = 0; i < batches; i++) {
        ism__batch b;
        size_t first = count / batches * i + (i < count % batches ? i : count % batches);
        size_t size = count / batches + (i < count % batches ? 1u : 0u);
        if (ism__cancelled(&own, i, batches, 1u)) return 0;
        b.task = task;
        b.context = context;
        b.first = first;
        if (system->parallel_for) system->parallel_for(system->user, size, ism__batch_task, &b);
        else for (k = 0; k < size; k++) ism__batch_task(&b, k);
    }
    return !(own.progress && ism__part_tell(&own, 1.0f));
}

/* ==== src/ism/inputs.h ==== */

/* ---- inputs: meshes, sources and views as the caller gives them ---- */

/* Returns element i of an array of vectors; stride 0 means that the vectors follow each other. */
static const float *ism__at(const float *array, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)array + (stride ? stride : 12u) * i);
}

/* Returns the axis and the exponent of a texel's lobe, four floats. */
static const float *ism__lobe(const ism_source *s, size_t i)
{
    return ism__at(s->lobes, s->lobe_stride ? s->lobe_stride : 16u, i);
}

/* Begins a call: notes where its progress and its log go, and which function the log names. */
static void ism__begin_job(const ism_system *system, const char *function, const ism_frame *frame,
                           ism__job *job)
{
    memset(job, 0, sizeof *job);
    job->frame = frame;
    job->part.progress = system->progress;
    job->part.user = system->user;
    job->part.to = 1.0f;
    job->log.log = system->log;
    job->log.user = system->user;
    job->log.function = function;
}

/* Logs that this pointer is NULL, and returns ISM_ERR_ARGUMENT. */
static ism_result ism__is_null(const ism__logger *log, const char *name)
{
    ism__log_text(log, name, "is NULL");
    return ISM_ERR_ARGUMENT;
}

static ism_result ism__no_memory(const ism__logger *log)
{
    ism__log_text(log, "system.allocator", "returned no memory");
    return ISM_ERR_ALLOC;
}

/* Checks the array to which surfels are written. */
static ism_result ism__check_list(const ism__logger *log, const ism_surfel *out, size_t capacity,
                                  const size_t *count)
{
    if (!count) return ism__is_null(log, "count");
    return !out && capacity ? ism__is_null(log, "out") : ISM_OK;
}

static ism_result ism__check_stride(const ism__logger *log, const char *name, size_t stride, size_t least)
{
    if (ism__stride_valid(stride, least)) return ISM_OK;
    ism__log_value(log, name, (double)stride, least == 12u ? "0 or a multiple of 4, at least 12"
                                            : least == 16u ? "0 or a multiple of 4, at least 16"
                                                           : "a multiple of 4");
    return ISM_ERR_ARGUMENT;
}

/* Returns 1 if a vector is unit (0.97 to 1.03 long), 0 if it is 0 0 0 or not finite, and -1 if it has another
   length. */
static int ism__unit_kind(ism__v3 v)
{
    float length2 = ism__v3_dot(v, v);
    if (ism__is_unit2(length2)) return 1;
    return !ism__v3_finite(v) || !(length2 > 0.0f || v.x != 0.0f || v.y != 0.0f || v.z != 0.0f) ? 0 : -1;
}

static size_t ism__mesh_triangles(const ism_mesh *mesh)
{
    return !mesh ? 0 : (mesh->indices || mesh->indices16 ? mesh->index_count : mesh->vertex_count) / 3u;
}

/* Checks a mesh, but for the values of its indices, which are checked while they are read. */
static ism_result ism__check_mesh(const ism__logger *log, const ism_mesh *mesh)
{
    int indexed = mesh->indices || mesh->indices16;
    size_t count = indexed ? mesh->index_count : mesh->vertex_count;
    if (mesh->indices && mesh->indices16) {
        ism__log_text(log, "mesh.indices", "and mesh.indices16 are both given");
        return ISM_ERR_ARGUMENT;
    }
    if (count % 3u != 0) {
        ism__log_value(log, indexed ? "mesh.index_count" : "mesh.vertex_count", (double)count,
                       "a multiple of 3");
        return ISM_ERR_ARGUMENT;
    }
    if (!mesh->positions && mesh->vertex_count) return ism__is_null(log, "mesh.positions");
    if (!mesh->vertex_count && count) {
        ism__log_value(log, "mesh.vertex_count", 0.0, "above 0, for there are indices");
        return ISM_ERR_ARGUMENT;
    }
    return ism__check_stride(log, "mesh.vertex_stride", mesh->vertex_stride, 12);
}

/* Returns index i of a mesh; if the mesh has no indices, i itself. */
static size_t ism__index(const ism_mesh *mesh, size_t i)
{
    return mesh->indices ? mesh->indices[i] : mesh->indices16 ? mesh->indices16[i] : i;
}

static ism_result ism__check_indices(const ism__logger *log, const ism_mesh *mesh)
{
    size_t i, count = mesh->indices || mesh->indices16 ? 3u * ism__mesh_triangles(mesh) : 0;
    for (i = 0; i < count; i++)
        if (ism__index(mesh, i) >= mesh->vertex_count) {
            ism__log_index(log, "mesh", i, ism__index(mesh, i), mesh->vertex_count);
            return ISM_ERR_INPUT;
        }
    return ISM_OK;
}

/* Checks that opacities are 0..1. A triangle whose opacity is not a number would not be drawn, and nobody
   would know why. */
static ism_result ism__check_opacities(const ism__logger *log, const ism_mesh *mesh)
{
    size_t i, count = mesh->opacities ? ism__mesh_triangles(mesh) : 0;
    for (i = 0; i < count; i++)
        if (!(mesh->opacities[i] >= 0.0f && mesh->opacities[i] <= 1.0f)) {
            ism__log_element(log, "mesh.opacities", i, "is", (double)mesh->opacities[i], "0..1");
            return ISM_ERR_INPUT;
        }
    return ISM_OK;
}

/* Loads the corners of a triangle whose indices are known to be in range. */
static void ism__corners(const ism_mesh *mesh, size_t t, ism__v3 p[3])
{
    size_t k;
    for (k = 0; k < 3u; k++)
        p[k] = ism__v3_load(ism__at(mesh->positions, mesh->vertex_stride, ism__index(mesh, 3u * t + k)));
}

/* Checks that vectors are unit, or mean that there is no receiver. */
static ism_result ism__check_units(const ism__logger *log, const char *name, const float *array,
                                   size_t stride, size_t count)
{
    size_t i;
    for (i = 0; i < count; i++) {
        ism__v3 v = ism__v3_load(ism__at(array, stride, i));
        if (ism__unit_kind(v) >= 0) continue;
        ism__log_element(log, name, i, "has the length", (double)ism__v3_length(v), "1 (0.97..1.03), or 0");
        return ISM_ERR_INPUT;
    }
    return ISM_OK;
}

/* Checks receivers, and finds the width and height of their picture; a list is a picture of one row. */
static ism_result ism__open_view(const ism__logger *log, const ism_points *p, ism__view *out)
{
    ism_result result;
    int k;
    if (!p) return ism__is_null(log, "points");
    if (!p->positions) return ism__is_null(log, "points.positions");
    if (!p->normals) return ism__is_null(log, "points.normals");
    if (!p->count || p->count > 1u << 28) {
        ism__log_value(log, "points.count", (double)p->count, "1..2^28");
        return p->count ? ISM_ERR_LIMIT : ISM_ERR_ARGUMENT;
    }
    if (p->width && p->count % p->width != 0) {
        ism__log_value(log, "points.width", (double)p->width, "0 or a divisor of points.count");
        return ISM_ERR_ARGUMENT;
    }
    if ((result = ism__check_stride(log, "points.position_stride", p->position_stride, 12)) != ISM_OK ||
        (result = ism__check_stride(log, "points.normal_stride", p->normal_stride, 12)) != ISM_OK ||
        (result = ism__check_stride(log, "points.geometric_normal_stride", p->geometric_normal_stride, 12)) !=
            ISM_OK ||
        (result = ism__check_stride(log, "points.albedo_stride", p->albedo_stride, 12)) != ISM_OK)
        return result;
    for (k = 0; k < 16; k++)
        if (!ism__finite(p->world_to_clip[k])) {
            ism__log_element(log, "points.world_to_clip", (uint64_t)k, "is", (double)p->world_to_clip[k],
                             "finite");
            return ISM_ERR_INPUT;
        }
    if (p->rows < ISM_ROWS_DEFAULT || p->rows >= ISM_ROWS_COUNT) {
        ism__log_value(log, "points.rows", (double)p->rows, "a value of ism_rows");
        return ISM_ERR_INPUT;
    }
    out->points = p;
    out->width = p->width ? p->width : (uint32_t)p->count;
    out->height = (uint32_t)(p->count / out->width);
    result = ism__check_units(log, "points.normals", p->normals, p->normal_stride, p->count);
    if (result != ISM_OK || !p->geometric_normals) return result;
    return ism__check_units(log, "points.geometric_normals", p->geometric_normals, p->geometric_normal_stride,
                            p->count);
}

/* Loads a receiver's position and normal. Returns 0 if there is no receiver. */
static int ism__receiver(const ism__view *view, size_t i, ism__v3 *p, ism__v3 *n)
{
    *p = ism__v3_load(ism__at(view->points->positions, view->points->position_stride, i));
    *n = ism__v3_load(ism__at(view->points->normals, view->points->normal_stride, i));
    return ism__v3_finite(*p) && ism__v3_finite(*n) && ism__v3_dot(*n, *n) > 0.25f;
}

/* Returns a receiver's geometric normal; if it has none, n, its normal. */
static ism__v3 ism__geometric_normal(const ism__view *view, size_t i, ism__v3 n)
{
    const ism_points *p = view->points;
    ism__v3 own;
    if (!p->geometric_normals) return n;
    own = ism__v3_load(ism__at(p->geometric_normals, p->geometric_normal_stride, i));
    return ism__v3_finite(own) && ism__v3_dot(own, own) > 0.25f ? own : n;
}

static float ism__luminance(const float *f) { return (f[0] + f[1] + f[2]) * (1.0f / 3.0f); }

static int ism__flux_ok(const float *f)
{
    return f[0] >= 0.0f && f[1] >= 0.0f && f[2] >= 0.0f && f[0] <= 1e30f && f[1] <= 1e30f && f[2] <= 1e30f;
}

/* Writes "sources[INDEX].NAME", for the log. */
static void ism__source_field(ism__message *m, size_t source, const char *name)
{
    m->used = 0;
    ism__message_text(m, "sources[");
    ism__message_count(m, source);
    ism__message_text(m, "].");
    ism__message_text(m, name);
}

/* Returns the flux of a pVPL, 0 if the pVPL cannot be used. Sets *bad if the data are at fault. If a vector
   is not unit, *wrong is set to the name of its array. */
static float ism__pvpl_luminance(const ism_source *s, size_t i, int *bad, const char **wrong)
{
    const float *f = ism__at(s->fluxes, s->flux_stride, i);
    ism__v3 p = ism__v3_load(ism__at(s->positions, s->position_stride, i)), n = p;
    int kind;
    *bad = 0;
    if (!ism__flux_ok(f)) return *bad = 1, 0.0f;
    if (!(ism__luminance(f) > 0.0f)) return 0.0f;
    if (s->kind != ISM_SOURCE_DIRECTIONS) n = ism__v3_load(ism__at(s->normals, s->normal_stride, i));
    kind = ism__unit_kind(n);
    if (kind < 0) *wrong = s->kind != ISM_SOURCE_DIRECTIONS ? "normals" : "positions";
    *bad = !ism__v3_finite(p) || kind == 0;
    if (s->lobes && s->kind != ISM_SOURCE_DIRECTIONS) {
        const float *lobe = ism__lobe(s, i);
        kind = ism__unit_kind(ism__v3_load(lobe));
        if (kind < 0) *wrong = "lobes";
        if (kind == 0 || !(lobe[3] >= 0.0f && lobe[3] <= 1e5f)) *bad = 1;
    }
    return *bad ? 0.0f : ism__luminance(f);
}

/* Logs that a vector of a source's texel is not unit; `wrong` is the array's name from ism__pvpl_luminance.
   */
static ism_result ism__not_unit(const ism__logger *log, const ism_source *s, size_t source, size_t i,
                                const char *wrong)
{
    ism__message name;
    ism__v3 v = ism__v3_load(wrong[0] == 'n'   ? ism__at(s->normals, s->normal_stride, i)
                             : wrong[0] == 'l' ? ism__lobe(s, i)
                                               : ism__at(s->positions, s->position_stride, i));
    ism__source_field(&name, source, wrong);
    ism__log_element(log, name.text, i, "has the length", (double)ism__v3_length(v), "1 (0.97..1.03), or 0");
    return ISM_ERR_INPUT;
}

static ism_result ism__check_source(const ism__logger *log, const ism_source *s, size_t index)
{
    ism__message name;
    ism_result result;
    if (s->kind < ISM_SOURCE_DEFAULT || s->kind >= ISM_SOURCE_COUNT) {
        ism__source_field(&name, index, "kind");
        ism__log_value(log, name.text, (double)s->kind, "a value of ism_source_kind");
        return ISM_ERR_INPUT;
    }
    ism__source_field(&name, index, !s->positions ? "positions" : !s->fluxes ? "fluxes" : "normals");
    if (!s->positions || !s->fluxes || (s->kind != ISM_SOURCE_DIRECTIONS && !s->normals))
        return ism__is_null(log, name.text);
    ism__source_field(&name, index, !s->width ? "width" : "height");
    if (!s->width || !s->height) {
        ism__log_value(log, name.text, 0.0, "above 0");
        return ISM_ERR_ARGUMENT;
    }
    ism__source_field(&name, index, "position_stride");
    if ((result = ism__check_stride(log, name.text, s->position_stride, 12)) != ISM_OK) return result;
    ism__source_field(&name, index, "normal_stride");
    if ((result = ism__check_stride(log, name.text, s->normal_stride, 12)) != ISM_OK) return result;
    ism__source_field(&name, index, "flux_stride");
    if ((result = ism__check_stride(log, name.text, s->flux_stride, 12)) != ISM_OK) return result;
    ism__source_field(&name, index, "lobe_stride");
    if ((result = ism__check_stride(log, name.text, s->lobe_stride, 16)) != ISM_OK) return result;
    ism__source_field(&name, index, "area_stride");
    return ism__check_stride(log, name.text, s->area_stride, 4);
}

/* Checks all sources, and counts their texels and the doubles that their prefix sums take. */
static ism_result ism__check_sources(const ism__logger *log, const ism_frame *f, size_t *total,
                                     size_t *doubles)
{
    size_t s, cells;
    *total = *doubles = 0;
    if (f->source_count && !f->sources) return ism__is_null(log, "frame.sources");
    for (s = 0; s < f->source_count; s++) {
        const ism_source *src = &f->sources[s];
        ism_result result = ism__check_source(log, src, s);
        if (result != ISM_OK) return result;
        if (!ism__mul_size(src->width, src->height, &cells) || cells > 1u << 26 ||
            *total > (1u << 26) - cells) {
            ism__log_element(log, "sources", s, "brings the texels of all to", (double)*total +
                             (double)src->width * (double)src->height, "2^26 at most");
            return ISM_ERR_LIMIT;
        }
        *total += cells;
        *doubles += ism__cdf2_doubles(src->width, src->height);
    }
    return ISM_OK;
}

/* ==== src/ism/formulas.h ==== */

/* ---- formulas: solid angle, form factor, dithering ---- */

/* Returns the solid angle of a triangle seen from the origin, in sr, exact for any size (Van Oosterom and
   Strackee 1983), and 0 for a triangle without area:
   tan(omega / 2) = a . (b x c) / (abc + (a . b) c + (a . c) b + (b . c) a). */
static float ism__solid_angle(const float pa[3], const float pb[3], const float pc[3])
{
    ism__v3 a = ism__v3_load(pa), b = ism__v3_load(pb), c = ism__v3_load(pc);
    float la = ism__v3_length(a), lb = ism__v3_length(b), lc = ism__v3_length(c);
    float top = fabsf(ism__v3_dot(a, ism__v3_cross(b, c))), omega;
    float below = la * lb * lc + ism__v3_dot(a, b) * lc + ism__v3_dot(a, c) * lb + ism__v3_dot(b, c) * la;
    if (!(top > 0.0f) || !ism__finite(top) || !ism__finite(below)) return 0.0f;
    omega = 2.0f * ism__atan2(top, below);
    return omega > 0.0f ? omega : 0.0f;
}

/* Returns the form factor from a point at the origin with the normal n to a flat polygon, whose corners go
   counter-clockwise as seen from the point, by Lambert's sum over the edges of the part above the horizon:
   F = 1 / 2 pi sum angle(a, b) n . (b x a) / |b x a|. *share is the part of the area that is left; share may
   be NULL. */
static float ism__form_factor(ism__v3 n, const ism__v3 *corner, uint32_t count, float *share)
{
    ism__v3 p[8];
    float sum = 0.0f, cut = 0.0f, whole = 0.0f;
    uint32_t i, k = 0;
    for (i = 0; i < count; i++) {
        ism__v3 a = corner[i], b = corner[(i + 1u) % count];
        float ha = ism__v3_dot(n, a), hb = ism__v3_dot(n, b);
        if (ha > 0.0f) p[k++] = a;
        if ((ha > 0.0f) != (hb > 0.0f)) p[k++] = ism__v3_madd(a, ism__v3_sub(b, a), ha / (ha - hb));
    }
    if (share) {
        ism__v3 s = ism__v3_make(0, 0, 0), t = s;
        for (i = 1; i + 1u < k; i++)
            s = ism__v3_add(s, ism__v3_cross(ism__v3_sub(p[i], p[0]), ism__v3_sub(p[i + 1u], p[0])));
        for (i = 1; i + 1u < count; i++)
            t = ism__v3_add(
                t, ism__v3_cross(ism__v3_sub(corner[i], corner[0]), ism__v3_sub(corner[i + 1u], corner[0])));
        cut = ism__v3_length(s);
        whole = ism__v3_length(t);
        *share = whole > 0.0f ? cut / whole : 1.0f;
    }
    for (i = 0; i < k; i++) {
        ism__v3 a = p[i], b = p[(i + 1u) % k], c = ism__v3_cross(b, a);
        float length = ism__v3_length(c);
        if (length > 0.0f) sum += ism__atan2(length, ism__v3_dot(a, b)) * (ism__v3_dot(n, c) / length);
    }
    return sum * 0.159154943f;
}

/* Returns whether a pixel of a surface with this opacity is drawn. Of each 2 x 2 pixels the opacities 0, .25,
   .5, .75 and 1 draw exactly 0 to 4 (paper 6.4). */
static int ism__dither(uint32_t x, uint32_t y, float opacity)
{
    static const float threshold[4] = { 0.125f, 0.625f, 0.875f, 0.375f };   /* Bayer's 2 x 2 */
    return opacity > threshold[(y & 1u) * 2u + (x & 1u)];
}

/* ==== src/ism/projections.h ==== */

/* ---- projections: the hemisphere about +z and the unit square (paper 6.1) ---- */

/* Writes the place in the unit disc of a place (a, b) in the square -1..1, and returns its radius. After
   Shirley and Chiu, "A low distortion map between disk and square", J. Graphics Tools 2(3), 1997. */
static float ism__square_to_disc(float a, float b, float *x, float *y)
{
    float r, phi, s, c;
    if (fabsf(a) > fabsf(b)) {
        r = a;
        phi = 0.785398163f * (b / a);
    } else {
        r = b;
        phi = b != 0.0f ? 1.57079633f - 0.785398163f * (a / b) : 0.0f;
    }
    ism__sincos(phi, &s, &c);
    *x = r * c;
    *y = r * s;
    return fabsf(r);
}

static void ism__disc_to_square(float x, float y, float *a, float *b)
{
    float r = sqrtf(x * x + y * y);
    if (fabsf(x) > fabsf(y)) {
        *a = x < 0.0f ? -r : r;
        *b = *a * 1.27323954f * ism__atan2(y, x < 0.0f ? -x : x) * (x < 0.0f ? -1.0f : 1.0f);
    } else {
        *b = y < 0.0f ? -r : r;
        *a = *b * 1.27323954f * ism__atan2(x, y < 0.0f ? -y : y) * (y < 0.0f ? -1.0f : 1.0f);
    }
}

/* Returns 1 - x^y for x in 0..1. A small difference keeps its digits, which x^y as a float would have lost.
   */
static float ism__power_gap(float x, float y)
{
    return x > 0.0f ? (float)(1.0 - ism__exp_core((double)y * ism__log_core(x))) : 1.0f;
}

/* Returns by how much a LOBE map stretches the disc of directions with this z and this sine of the angle from
   the axis. */
static float ism__lobe_stretch(float z, float sine, float exponent)
{
    float r = ism__power_gap(z < 1.0f ? z : 1.0f, exponent + 1.0f);
    return sine > 1e-12f ? sqrtf(r > 0.0f ? r : 0.0f) / sine : 1.0f;
}

/* In the map of a LOBE equal areas have equal integrals of cos^e, which makes the radius in the disc the root
   of 1 - cos^(e + 1). With e = 1 this is the hemisphere seen from above, the map COSINE. */
ISM_DEF void ism_map_direction(ism_projection projection, float exponent, const float uv[2],
                               float direction[3])
{
    float a = 2.0f * uv[0] - 1.0f, b = 2.0f * uv[1] - 1.0f, r, x;
    float y, z, s;
    if (projection == ISM_PROJECTION_PARABOLOID) {
        r = a * a + b * b;
        s = 2.0f / (1.0f + r);
        x = a * s;
        y = b * s;
        z = (1.0f - r) / (1.0f + r);
    } else if (projection == ISM_PROJECTION_OCTAHEDRAL) {
        ism__v3 v;
        x = 0.5f * (a + b);
        y = 0.5f * (a - b);
        v = ism__v3_normalize(ism__v3_make(x, y, 1.0f - fabsf(x) - fabsf(y)));
        x = v.x;
        y = v.y;
        z = v.z;
    } else {
        float e = projection == ISM_PROJECTION_LOBE ? exponent : 1.0f, sine;
        r = ism__square_to_disc(a, b, &x, &y);
        s = 1.0f - r * r;
        s = s > 0.0f ? s : 0.0f;
        z = e == 1.0f ? sqrtf(s) : ism__pow(s, 1.0f / (e + 1.0f));
        sine = e == 1.0f ? r : sqrtf(ism__power_gap(s, 2.0f / (e + 1.0f)));
        s = r > 1e-12f ? sine / r : 1.0f;
        x *= s;
        y *= s;
    }
    direction[0] = x;
    direction[1] = y;
    direction[2] = z;
}

ISM_DEF int ism_map_coordinates(ism_projection projection, float exponent, const float direction[3],
                                float uv[2])
{
    float x = direction[0], y = direction[1], z = direction[2];
    float a, b, s;
    if (!(z > 0.0f)) return 0;
    if (projection == ISM_PROJECTION_PARABOLOID) {
        a = x / (1.0f + z);
        b = y / (1.0f + z);
    } else if (projection == ISM_PROJECTION_OCTAHEDRAL) {
        s = 1.0f / (fabsf(x) + fabsf(y) + z);
        a = (x + y) * s;
        b = (x - y) * s;
    } else {
        float e = projection == ISM_PROJECTION_LOBE ? exponent : 1.0f;
        if (e != 1.0f) {
            s = ism__lobe_stretch(z, sqrtf(x * x + y * y), e);
            x *= s;
            y *= s;
        }
        ism__disc_to_square(x, y, &a, &b);
    }
    a = 0.5f * a + 0.5f;
    b = 0.5f * b + 0.5f;
    uv[0] = a < 0.0f ? 0.0f : a < 1.0f ? a : 1.0f;
    uv[1] = b < 0.0f ? 0.0f : b < 1.0f ? b : 1.0f;
    return 1;
}

static ism__v3 ism__to_local(const ism__orientation *f, ism__v3 v)
{
    return ism__v3_make(ism__v3_dot(f->x, v), ism__v3_dot(f->y, v), ism__v3_dot(f->z, v));
}

static ism__v3 ism__to_world(const ism__orientation *f, ism__v3 v)
{
    return ism__v3_madd(ism__v3_madd(ism__v3_scale(f->x, v.x), f->y, v.y), f->z, v.z);
}

static ism_projection ism__projection_of(const ism_maps *m, const ism_vpl *v)
{
    if (m->desc.projection == ISM_PROJECTION_LOBE && v->exponent == 1.0f) return ISM_PROJECTION_COSINE;
    return m->desc.projection;
}

/* Returns the axes of a VPL's map. z is the lobe's axis in maps of LOBE, the normal in others, and the way
   that light travels in maps of directions. */
static ism__orientation ism__vpl_axes(const ism_maps *m, const ism_vpl *v)
{
    ism__orientation f;
    f.z = ism__v3_load(ism__projection_of(m, v) == ISM_PROJECTION_LOBE && !v->directional ? v->axis
                                                                                          : v->normal);
    ism__v3_basis(f.z, &f.x, &f.y);
    return f;
}

/* Returns the texel in which u, 0..1, lies; the nearest texel for u beyond, and the first for what is not a
   number. */
static uint32_t ism__texel_of(float u, uint32_t size)
{
    float x = u * (float)size;
    if (!(x > 0.0f)) return 0;
    return x < (float)size ? (uint32_t)x : size - 1u;
}

/* ==== src/ism/importance.h ==== */

/* ---- importance: what a pVPL does to the picture (paper 4.1, 4.2) ---- */

typedef struct ism__choice {
    ism_maps         *m;
    const ism__job   *job;
    float             extent;       /* diagonal of the receivers' box */
    size_t            source;       /* the source that is weighed; what follows is its own */
    float *lum, *effect, *out;      /* flux; effect on the picture, of which by_mean says how it is a mean;
                                       the effect blurred, as a number that goes as light does */
    int               by_mean;      /* the effect is the mean; 0: the mean square, of which the root counts */
    uint32_t          seed;
    float             blur_radius;
    float             from, to;     /* share of the call's progress */
} ism__choice;

/* Returns how much light a unit of flux at q adds to a receiver at p: cos cos / d^2, bounded at distances
   below a hundredth of the picture's extent, and for directions the receiver's cosine. Lobes are taken for
   light that is equal all round, since an importance need not be exact. */
static float ism__unit_flux_light(const ism_source *s, ism__v3 q, ism__v3 n, ism__v3 p, ism__v3 pn,
                                  float extent)
{
    ism__v3 d;
    float d2, a, b;
    if (s->kind == ISM_SOURCE_DIRECTIONS) {
        a = ism__v3_dot(pn, q);
        return a > 0.0f ? a : 0.0f;
    }
    d = ism__v3_sub(q, p);
    d2 = ism__v3_dot(d, d) + 1e-4f * extent * extent + 1e-30f;
    a = ism__v3_dot(pn, d);
    b = s->lobes ? sqrtf(d2) : -ism__v3_dot(n, d);
    return a > 0.0f && b > 0.0f ? a * b / (d2 * d2) : 0.0f;
}

/* Writes the place of a world position in pixels. Returns 0 if that place is at infinity or unknown. A
   position behind the camera has the mirrored place, as in paper 4.2. */
static int ism__to_pixel(const ism__view *view, ism__v3 p, float *x, float *y)
{
    const float *m = view->points->world_to_clip;
    float cx = m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12],
          cy = m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13];
    float w = m[3] * p.x + m[7] * p.y + m[11] * p.z + m[15];
    float lx, ly;
    if (!(fabsf(w) > 1e-20f)) return 0;
    lx = cx / w;
    ly = cy / w;
    if (!(fabsf(lx) < 8.0f && fabsf(ly) < 8.0f)) return 0;
    *x = (0.5f * lx + 0.5f) * (float)view->width;
    *y = (view->points->rows == ISM_ROWS_TOP_FIRST ? 0.5f - 0.5f * ly : 0.5f * ly + 0.5f) *
         (float)view->height;
    return 1;
}

/* Returns an estimate of the effect of one pVPL on the picture, by a jittered grid of receivers. Every other
   sample, as on a chessboard, is guided: its density falls as min(1, (r0 / r)^2) about the pVPL's own place.
   Guided and other samples are weighted by the balance heuristic, so that no place is forgotten. In an even
   grid rows and columns have as many of either kind, and guided samples take their numbers from their cells;
   in an odd grid they have numbers of their own, in steps of radius and of the golden ratio. */
static float ism__estimate_effect(const ism__choice *c, const ism_source *s, size_t i)
{
    const ism__view *view = &c->job->view;
    uint32_t grid = c->m->desc.view_grid_side, k, count = grid * grid;
    uint32_t w = view->width, h = view->height;
    ism__v3 q = ism__v3_load(ism__at(s->positions, s->position_stride, i)), n = q, p, pn;
    float cx = 0.0f, cy = 0.0f, r0 = 0.05f * (float)(w > h ? w : h);
    float reach = (float)w + (float)h, sum = 0.0f;
    uint32_t turn = ism__hash_combine(c->seed, (uint32_t)i * 256u + 255u), rank = 0;
    float inner, norm, uniform = 1.0f / ((float)w * (float)h), share = (float)(count / 2u) / (float)count;
    int guided = c->m->desc.importance == ISM_IMPORTANCE_GUIDED ||
                 c->m->desc.importance == ISM_IMPORTANCE_GUIDED_MEAN;
    guided = guided && s->kind != ISM_SOURCE_DIRECTIONS && h > 1u && count > 1u && r0 >= 1.0f;
    guided = guided && ism__to_pixel(view, q, &cx, &cy) && reach > r0;
    inner = 1.0f / (1.0f + 2.0f * ism__log(reach / r0));    /* share of the disc r < r0 */
    norm = inner / (ISM__PI * r0 * r0);                     /* density inside it */
    if (s->kind != ISM_SOURCE_DIRECTIONS) n = ism__v3_load(ism__at(s->normals, s->normal_stride, i));
    for (k = 0; k < count; k++) {
        uint32_t hash = ism__hash_combine(c->seed, (uint32_t)i * 256u + k);
        float u = ((float)(k % grid) + ism__to_unit(hash)) / (float)grid;
        float v = ((float)(k / grid) + ism__to_unit(ism__hash32(hash))) / (float)grid;
        float x = u * (float)w, y = v * (float)h, density = uniform;
        if (guided && ((k % grid + k / grid) & 1u)) {
            float r, sine, cosine;
            if (grid & 1u) {
                u = ((float)rank + ism__to_unit(hash)) / (float)(count / 2u);
                v = ism__to_unit(turn + rank++ * 2654435769u);
            }
            r = u < inner ? r0 * sqrtf(u / inner) : r0 * ism__pow(reach / r0, (u - inner) / (1.0f - inner));
            ism__sincos(6.28318531f * v, &sine, &cosine);
            x = cx + r * cosine;
            y = cy + r * sine;
        }
        if (!(x >= 0.0f && y >= 0.0f && x < (float)w && y < (float)h)) continue;
        if (guided) {
            float r2 = (x - cx) * (x - cx) + (y - cy) * (y - cy);
            density = (1.0f - share) * uniform + share * norm * (r2 > r0 * r0 ? r0 * r0 / r2 : 1.0f);
        }
        if (ism__receiver(view, (size_t)ism__texel_of(y / (float)h, h) * w + ism__texel_of(x / (float)w, w),
                          &p, &pn)) {
            float e = ism__unit_flux_light(s, q, n, p, pn, c->extent);
            sum += (c->by_mean ? e : e * e) * (uniform / density);
        }
    }
    /* The root of a mean square is taken after the blur. The picture's squared error is least if VPLs are
       chosen in proportion to that root, not to the mean. */
    return sum / (float)count;
}

static void ism__estimate_task(void *context, size_t row)
{
    ism__choice *c = (ism__choice *)context;
    const ism_source *s = &c->job->frame->sources[c->source];
    size_t x;
    for (x = 0; x < s->width; x++) {
        size_t i = row * s->width + x;
        c->effect[i] = c->lum[i] > 0.0f ? ism__estimate_effect(c, s, i) : 0.0f;
    }
}

/* Returns what a blurred effect counts in the choice. */
static float ism__effect_of(const ism__choice *c, float effect)
{
    return c->by_mean ? effect : sqrtf(effect);
}

/* Blurs the effects of a row of texels over neighbours on the same surface (paper 6.5), and takes roots of
   mean squares. Fluxes are not blurred. */
static void ism__blur_task(void *context, size_t row)
{
    ism__choice *c = (ism__choice *)context;
    const ism_source *s = &c->job->frame->sources[c->source];
    int radius = (int)c->blur_radius, x, y;
    int w = (int)s->width, h = (int)s->height;
    for (x = 0; x < w; x++) {
        size_t i = row * s->width + (size_t)x;
        ism__v3 q = ism__v3_load(ism__at(s->positions, s->position_stride, i));
        ism__v3 n = ism__v3_load(ism__at(s->normals, s->normal_stride, i));
        float sum = 0.0f, weights = 0.0f;
        int y0 = (int)row - radius, y1 = (int)row + radius, x0 = x - radius;
        int x1 = x + radius, k;
        c->out[i] = 0.0f;
        if (!(c->lum[i] > 0.0f)) continue;
        for (y = y0 > 0 ? y0 : 0; y <= y1 && y < h; y++)
            for (k = x0 > 0 ? x0 : 0; k <= x1 && k < w; k++) {
                size_t j = (size_t)y * s->width + (size_t)k;
                ism__v3 d;
                float weight;
                if (!(c->lum[j] > 0.0f)) continue;
                d = ism__v3_sub(ism__v3_load(ism__at(s->positions, s->position_stride, j)), q);
                weight = ism__v3_dot(n, ism__v3_load(ism__at(s->normals, s->normal_stride, j)));
                if (weight <= 0.5f || fabsf(ism__v3_dot(n, d)) > 0.3f * ism__v3_length(d)) continue;
                sum += weight * c->effect[j];
                weights += weight;
            }
        c->out[i] = ism__effect_of(c, weights > 0.0f ? sum / weights : c->effect[i]);
    }
}

/* Returns the diagonal of the receivers' box. */
static float ism__extent(const ism__view *view)
{
    ism__v3 lo = ism__v3_make(1e30f, 1e30f, 1e30f), hi = ism__v3_make(-1e30f, -1e30f, -1e30f), p, n;
    size_t i, count = view->points->count, step = count / 65536u + 1u;
    for (i = 0; i < count; i += step)
        if (ism__receiver(view, i, &p, &n)) {
            lo = ism__v3_min(lo, p);
            hi = ism__v3_max(hi, p);
        }
    return lo.x <= hi.x ? ism__v3_length(ism__v3_sub(hi, lo)) : 0.0f;
}

/* Writes the fluxes of one source into c->lum, and into c->out the effect of a unit of each on the picture.
   */
static ism_result ism__weigh_source(ism__choice *c, const ism_source *s, double *flux)
{
    ism_maps *m = c->m;
    size_t count = (size_t)s->width * s->height, i;
    const char *wrong = NULL;
    float share = c->to - c->from;
    uint32_t radius;
    int bad;
    *flux = 0.0;
    for (i = 0; i < count; i++) {
        c->lum[i] = ism__pvpl_luminance(s, i, &bad, &wrong);
        if (wrong) return ism__not_unit(&c->job->log, s, c->source, i, wrong);
        m->stats.bad_pvpls += (uint64_t)bad;
        *flux += (double)c->lum[i];
        if (s->kind != ISM_SOURCE_DIRECTIONS && c->lum[i] > 0.0f) {
            const float *f = ism__at(s->fluxes, s->flux_stride, i);
            int k;
            for (k = 0; k < 3; k++) m->stats.flux[k] += (double)f[k];
        }
    }
    for (i = 0; i < count; i++) c->out[i] = 0.0f;
    if (m->desc.importance == ISM_IMPORTANCE_FLUX || !(*flux > 0.0)) return ISM_OK;
    if (!ism__run(m, &c->job->part, c->from, c->from + 0.8f * share, s->height, ism__estimate_task, c))
        return ISM_ERR_CANCELLED;
    radius = m->desc.blur_radius > 0 ? (uint32_t)m->desc.blur_radius : 0;
    if (!m->desc.blur_radius) {
        radius = (uint32_t)(0.05f * (float)(s->width < s->height ? s->width : s->height));
        radius = radius < 6u ? radius : 6u;
    }
    c->blur_radius = (float)radius;
    if (s->scattered || s->kind == ISM_SOURCE_DIRECTIONS || !radius)
        for (i = 0; i < count; i++) c->out[i] = ism__effect_of(c, c->effect[i]);
    else if (!ism__run(m, &c->job->part, c->from + 0.8f * share, c->to, s->height, ism__blur_task, c))
        return ISM_ERR_CANCELLED;
    return ISM_OK;
}

/* Writes the importances into c->out: flux x (effect + a constant, so that no texel is forgotten). The
   constant makes choice by flux alone a given share of all sources together: if it were a share of each
   source, one with a few great effects would leave the others nothing. Fluxes of directions are irradiances,
   and have a constant of their own. */
static void ism__add_shares(ism__choice *c, const ism__source_of *of)
{
    const ism_frame *f = c->job->frame;
    double share = (double)c->m->desc.flux_share, flux[2] = { 0.0, 0.0 }, total = 0.0;
    double kinds, least[2];
    size_t s, i = 0, end;
    for (s = 0; s < f->source_count; s++) {
        flux[f->sources[s].kind == ISM_SOURCE_DIRECTIONS] += of[s].flux;
        for (end = i + (size_t)f->sources[s].width * f->sources[s].height; i < end; i++)
            total += (double)(c->lum[i] * c->out[i]);
    }
    kinds = flux[0] > 0.0 && flux[1] > 0.0 ? 2.0 : 1.0;
    for (s = 0; s < 2; s++)
        least[s] =
            total > 0.0 && flux[s] > 0.0 ? total / kinds / flux[s] * share / (1.0 - 0.999 * share) : 1.0;
    for (s = i = 0; s < f->source_count; s++) {
        float lowest = (float)least[f->sources[s].kind == ISM_SOURCE_DIRECTIONS];
        for (end = i + (size_t)f->sources[s].width * f->sources[s].height; i < end; i++)
            c->out[i] = c->lum[i] * (c->out[i] + lowest);
    }
}

/* ==== src/ism/inter_texel.h ==== */

/* ---- inter-texel: VPLs between the texels of a source (paper 6.5) ---- */

/* Computes sample (x + fx, y + fy) of a grid as a mixture of the four texels about it, those that lie on one
   surface (paper 6.5). If the surface is curved, their chord may run behind it, and a VPL there would light a
   sheet's back: the sample lies on the chord or on the mean of the four tangent planes, whichever is farther
   out. Returns the distance to the farthest of the texels. */
static float ism__inter_texel(const ism__view *view, const ism_source *s, const ism__cdf2_sample *at,
                              ism__v3 *p, ism__v3 *n)
{
    size_t i0 = (size_t)at->y * s->width + at->x;
    ism__v3 p0 = ism__v3_load(ism__at(s->positions, s->position_stride, i0)),
            n0 = ism__v3_load(ism__at(s->normals, s->normal_stride, i0));
    ism__v3 sum = ism__v3_make(0, 0, 0), normal = sum, offsets[4], normals[4];
    float sx = at->fx - 0.5f, sy = at->fy - 0.5f, weights = 0.0f, spacing = 0.0f;
    float x0, y0, xk, yk;
    float share[4], behind = 0.0f;
    int k, used = 0, known = ism__to_pixel(view, p0, &x0, &y0);
    for (k = 0; k < 4; k++) {
        int64_t x = (int64_t)at->x + (k & 1 ? (sx < 0.0f ? -1 : 1) : 0),
                y = (int64_t)at->y + (k & 2 ? (sy < 0.0f ? -1 : 1) : 0);
        float w = (k & 1 ? fabsf(sx) : 1.0f - fabsf(sx)) * (k & 2 ? fabsf(sy) : 1.0f - fabsf(sy)), length;
        size_t i = (size_t)y * s->width + (size_t)x;
        ism__v3 q, nq, d;
        if (x < 0 || y < 0 || x >= (int64_t)s->width || y >= (int64_t)s->height) continue;
        if (!ism__flux_ok(ism__at(s->fluxes, s->flux_stride, i)) ||
            !(ism__luminance(ism__at(s->fluxes, s->flux_stride, i)) > 0.0f))
            continue;
        q = ism__v3_load(ism__at(s->positions, s->position_stride, i));
        nq = ism__v3_load(ism__at(s->normals, s->normal_stride, i));
        d = ism__v3_sub(q, p0);
        length = ism__v3_length(d);
        if (k && (!ism__v3_finite(nq) || !(ism__v3_dot(n0, nq) > 0.9f) ||
                  !(fabsf(ism__v3_dot(n0, d)) <= 0.1f * length))) continue;
        if (k && known && ism__to_pixel(view, q, &xk, &yk)) {   /* a Gaussian with variance 0.01, in clip
                                                                   space */
            float ex = 2.0f * (xk - x0) / (float)view->width, ey = 2.0f * (yk - y0) / (float)view->height;
            w *= ism__exp(-50.0f * (ex * ex + ey * ey));
        }
        sum = ism__v3_madd(sum, d, w);
        normal = ism__v3_madd(normal, nq, w);
        weights += w;
        offsets[used] = d;
        normals[used] = nq;
        share[used++] = w;
        if (length > spacing) spacing = length;
    }
    *p = p0;
    *n = n0;
    if (!(weights > 0.0f)) return spacing;
    *n = ism__v3_normalize(normal);
    sum = ism__v3_scale(sum, 1.0f / weights);
    for (k = 0; k < used; k++)
        behind += share[k] / weights * ism__v3_dot(normals[k], ism__v3_sub(offsets[k], sum)) *
                  ism__v3_dot(normals[k], *n);
    *p = ism__v3_add(p0, behind > 0.0f ? ism__v3_madd(sum, *n, behind) : sum);
    return spacing;
}

/* ==== src/ism/vpls.h ==== */

/* ---- vpls: drawn from the importances (paper 4.1) ---- */

/* Makes a VPL from one of `count` samples, which was chosen with this probability. */
static void ism__make_vpl(const ism_maps *m, const ism__job *job, size_t source, const ism__cdf2_sample *at,
                          double probability, uint32_t count, ism_vpl *v)
{
    const ism_source *s = &job->frame->sources[source];
    size_t i = (size_t)at->y * s->width + at->x;
    const float *flux = ism__at(s->fluxes, s->flux_stride, i);
    ism__v3 p = ism__v3_load(ism__at(s->positions, s->position_stride, i)), n;
    float scale = (float)(1.0 / ((double)count * probability)), spacing = 0.0f;
    int k;
    memset(v, 0, sizeof *v);
    v->source = (uint32_t)source;
    v->texel = (uint32_t)i;
    v->directional = s->kind == ISM_SOURCE_DIRECTIONS;
    if (v->directional) {
        p = ism__v3_normalize(p);
        n = ism__v3_scale(p, -1.0f);
    } else {
        n = ism__v3_normalize(ism__v3_load(ism__at(s->normals, s->normal_stride, i)));
#ifndef ISM_WITHOUT_INTER_TEXEL
        if (!s->scattered && !m->desc.no_inter_texel) spacing = ism__inter_texel(&job->view, s, at, &p, &n);
#else
        (void)m;
#endif
    }
    ism__v3_store(v->position, p);
    ism__v3_store(v->normal, n);
    ism__v3_store(v->axis, n);
    v->exponent = 1.0f;
    if (s->lobes && !v->directional) {
        ism__v3_store(v->axis, ism__v3_normalize(ism__v3_load(ism__lobe(s, i))));
        v->exponent = ism__lobe(s, i)[3];
    }
    /* The flux of a texel that is almost never chosen is cut off at the most that a VPL may have. */
    for (k = 0; k < 3; k++) v->flux[k] = flux[k] * scale < 1e30f ? flux[k] * scale : 1e30f;
    if (s->areas && !v->directional)
        v->area = *ism__at(s->areas, s->area_stride ? s->area_stride : 4u, i) * scale;
    if (!(v->area >= 0.0f) || !ism__finite(v->area)) v->area = 0.0f;
    v->edge = spacing;      /* the distance to the farthest neighbour, for ism__flag_jumps; ism__edge_task
                               then writes the edge */
}

/* Marks the VPLs that jumped: they are of another source than in the last frame, or farther than a texel from
   where they were. */
static void ism__flag_jumps(ism_maps *m)
{
    const ism_vpl *old = (const ism_vpl *)m->previous.data;
    uint32_t i;
    m->stats.jumped = 0;
    for (i = 0; i < m->vpl_count; i++) {
        ism_vpl *v = &m->vpls[i];
        float limit = v->edge;
        ism__v3 d;
        if (i >= m->previous_count) continue;
        d = ism__v3_sub(ism__v3_load(v->position), ism__v3_load(old[i].position));
        v->jumped = v->source != old[i].source || ism__v3_dot(d, d) > limit * limit;
        m->stats.jumped += (uint32_t)v->jumped;
    }
}

/* Finds the edge of the square that a VPL becomes for receivers near by. The square has the VPL's area, but
   reaches no farther than its neighbours are. VPLs at one place, of a texel that was chosen twice, share a
   square of their areas' sum: two squares of one's area would be twice as bright as the surface. */
static void ism__edge_task(void *context, size_t index)
{
    ism_maps *m = (ism_maps *)context;
    ism_vpl *v = &m->vpls[index];
    ism__v3 p = ism__v3_load(v->position), n = ism__v3_load(v->normal);
    float near2[4] = { 1e30f, 1e30f, 1e30f, 1e30f }, most, area = v->area;
    uint32_t i, k;
    v->edge = 0.0f;
    if (v->directional || v->exponent != 1.0f) return;
    for (i = 0; i < m->vpl_count; i++) {
        const ism_vpl *o = &m->vpls[i];
        ism__v3 d = ism__v3_sub(ism__v3_load(o->position), p);
        float d2 = ism__v3_dot(d, d);
        if (i == index || d2 >= near2[3] || o->directional) continue;
        if (ism__v3_dot(n, ism__v3_load(o->normal)) < 0.5f) continue;
        if (!(d2 > 0.0f)) {
            area += o->area;
            continue;
        }
        for (k = 3; k > 0 && near2[k - 1u] > d2; k--) near2[k] = near2[k - 1u];
        near2[k] = d2;
    }
    most = near2[3] < 1e30f ? ISM__PI * near2[3] : 0.0f;
    area = area > 0.0f ? (most > 0.0f && area > 2.0f * most ? 2.0f * most : area) : 0.25f * most;
    v->edge = sqrtf(area);
}

/* Finds the squares of VPLs that were chosen or set, which have no near points yet. */
static ism_result ism__finish_vpls(ism_maps *m, const ism__part *part, float from, float to)
{
    uint32_t i;
    for (i = 0; i < m->vpl_count; i++) m->vpls[i].reach = 0.0f;
    m->near_count = m->stats.near_points = 0;
    if (!ism__run(m, part, from, to, m->vpl_count, ism__edge_task, m))
        return m->chosen = 0, ISM_ERR_CANCELLED;
    m->stats.vpls = m->vpl_count;
    m->chosen = 1;
    return ISM_OK;
}

/* Draws sample i of count at ((i + 0.5) / count, golden ratio sequence): the first number chooses source and
   row, the second the column. Returns 0 if there is no such sample. */
static int ism__draw_vpl(const ism_maps *m, const ism__job *job, double total, uint32_t i, uint32_t count,
                     uint32_t stream, ism_vpl *v)
{
    const ism__source_of *of = (const ism__source_of *)m->sources.data;
    const ism_frame *f = job->frame;
    uint32_t key = m->desc.unstable ? ism__hash_combine(m->desc.seed, f->index) : m->desc.seed;
    uint32_t shift_u = ism__hash_combine(key, stream), shift_v = ism__hash_combine(key, stream + 1u);
    double u = ((double)i + 0.5) / (double)count + (m->desc.unstable ? (double)ism__to_unit(shift_u) : 0.0),
           rest;
    ism__cdf2_sample at;
    ism__cdf2 cdf;
    size_t s = 0, last = 0, k;
    u = (u - floor(u)) * total;
    for (k = 0; k < f->source_count; k++)
        if (of[k].total > 0.0) last = k;
    rest = u;
    for (s = 0; s < last && !(rest < of[s].total); s++) rest -= of[s].total;
    cdf.rows = (const double *)m->cdf.data + of[s].cdf_first;
    cdf.sums = cdf.rows + f->sources[s].height + 1u;
    cdf.width = f->sources[s].width;
    cdf.height = f->sources[s].height;
    at = ism__cdf2_sample_at(&cdf, ism__to_unit(i * 2654435769u + shift_v), (float)(rest / of[s].total));
    if (!(at.probability > 0.0f)) return 0;
    ism__make_vpl(m, job, s, &at, (double)at.probability * of[s].total / total, count, v);
    return 1;
}

/* Draws the VPLs in proportion to the importances, whose sum is `total`. */
static void ism__draw_all_vpls(ism_maps *m, const ism__job *job, double total)
{
    uint32_t n = m->desc.vpl_count, i;
    m->vpl_count = 0;
    for (i = 0; i < n && total > 0.0; i++)
        m->vpl_count += (uint32_t)ism__draw_vpl(m, job, total, i, n, 11u, &m->vpls[m->vpl_count]);
}

/* ==== src/ism/near_points.h ==== */

/* ---- near points: in place of the VPLs that are near a receiver ---- */

/* The light of all VPLs is right on the mean, but not beside one of them: in a corner a single VPL makes a
   spot of light that a whole surface should have spread. There near points take over, samples of a second,
   finer choice, each as far as its reach. The reach depends on the place alone, so that the sum over VPLs
   gives way to the sum over near points without a loss. */
typedef struct ism__near_work {
    ism_maps        *m;
    const ism__job  *job;
    double           total;
    const uint64_t  *sorted;        /* the VPLs of surfaces without lobes, in their order along `axis`; the
                                       low half of each is the VPL's number */
    uint32_t         sorted_count;
    uint32_t         drawn;         /* samples of the second choice */
    uint32_t         axis;          /* along which the VPLs' box is longest */
    ism_near_point  *out;           /* in the order in which they are drawn; vpl < 0: there is no point */
} ism__near_work;

/* Returns whether near points may take the place of a VPL: a diffuse one on a surface. */
static int ism__has_near(const ism_vpl *v) { return !v->directional && v->exponent == 1.0f; }

/* Returns the VPL with this place in the sorted list. */
static const ism_vpl *ism__sorted_vpl(const ism__near_work *w, uint32_t i)
{
    return &w->m->vpls[(uint32_t)w->sorted[i]];
}

/* Returns how far a near point at p reaches, and writes the number of the nearest VPL, in whose choice alone
   VPLs with other normals count as farther. The sorted VPLs are walked through both ways from p, until their
   distance along the axis alone is too large. */
static float ism__reach_of(const ism__near_work *w, ism__v3 p, ism__v3 n, uint32_t *nearest)
{
    float near2[ISM__NEAR_RANK], best = 1e30f;
    uint32_t lo = 0, hi = w->sorted_count, left;
    uint32_t right, k;
    float x = w->axis == 0 ? p.x : w->axis == 1u ? p.y : p.z;
    for (k = 0; k < ISM__NEAR_RANK; k++) near2[k] = 1e30f;
    while (lo < hi) {
        uint32_t mid = lo + (hi - lo) / 2u;
        if (ism__sorted_vpl(w, mid)->position[w->axis] < x) lo = mid + 1u;
        else hi = mid;
    }
    for (left = right = lo; left > 0 || right < w->sorted_count;) {
        float before = left > 0 ? x - ism__sorted_vpl(w, left - 1u)->position[w->axis] : 1e30f, d2, cosine;
        float behind = right < w->sorted_count ? ism__sorted_vpl(w, right)->position[w->axis] - x : 1e30f;
        int leftwards = right == w->sorted_count || (left > 0 && before < behind);
        float step = leftwards ? before : behind;
        uint32_t i = (uint32_t)w->sorted[leftwards ? --left : right++];
        const ism_vpl *v = &w->m->vpls[i];
        ism__v3 d = ism__v3_sub(ism__v3_load(v->position), p);
        if (step * step > near2[ISM__NEAR_RANK - 1u] && step * step > best) break;
        d2 = ism__v3_dot(d, d);
        for (k = ISM__NEAR_RANK - 1u; k > 0 && near2[k - 1u] > d2; k--) near2[k] = near2[k - 1u];
        if (near2[k] > d2) near2[k] = d2;
        cosine = ism__v3_dot(n, ism__v3_load(v->normal));
        d2 *= cosine > 0.5f ? 1.0f : cosine > 0.0f ? 4.0f : 16.0f;
        if (d2 < best) {
            best = d2;
            *nearest = i;
        }
    }
    return 2.0f * sqrtf(near2[ISM__NEAR_RANK - 1u]);
}

static void ism__reach_task(void *context, size_t index)
{
    const ism__near_work *w = (const ism__near_work *)context;
    ism_vpl *v = &w->m->vpls[index];
    uint32_t nearest = 0;
    if (ism__has_near(v))
        v->reach = ism__reach_of(w, ism__v3_load(v->position), ism__v3_load(v->normal), &nearest);
}

/* Draws 64 near points. A point's square has the texel's area, or that which the point stands for if it is
   larger, but no more than an eighth of the disc within its reach. Without areas, the density of VPLs around
   the point tells the area. */
static void ism__near_task(void *context, size_t index)
{
    const ism__near_work *w = (const ism__near_work *)context;
    uint32_t i, k;
    for (i = (uint32_t)index * ISM__NEAR_BLOCK; i < w->drawn && i < (uint32_t)(index + 1u) * ISM__NEAR_BLOCK;
         i++) {
        ism_near_point *to = &w->out[i];
        const ism_source *s;
        uint32_t nearest = 0;
        float area, most;
        ism_vpl v;
        to->vpl = -1.0f;
        if (!ism__draw_vpl(w->m, w->job, w->total, i, w->drawn, 13u, &v) || !ism__has_near(&v)) continue;
        s = &w->job->frame->sources[v.source];
        for (k = 0; k < 3u; k++) {
            to->position[k] = v.position[k];
            to->normal[k] = v.normal[k];
            to->flux[k] = v.flux[k];
        }
        to->reach = ism__reach_of(w, ism__v3_load(v.position), ism__v3_load(v.normal), &nearest);
        area = s->areas ? *ism__at(s->areas, s->area_stride ? s->area_stride : 4u, v.texel)
                        : ISM__PI * 0.25f * to->reach * to->reach /
                              (float)(ISM__NEAR_RANK * (uint32_t)w->m->desc.near_point_count);
        if (!(area >= v.area) || !ism__finite(area)) area = v.area;
        most = 0.125f * ISM__PI * to->reach * to->reach;
        to->edge = sqrtf(area < most ? area : most);
        to->vpl = (float)nearest;
    }
}

/* Returns ten bits spread over thirty, each at every third place. */
static uint32_t ism__spread_bits(uint32_t x)
{
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

/* Writes a key for each point that was drawn, and returns how many there are. A key's upper half is the place
   on Morton's curve through the box of all points, its lower half is the point's number. */
static uint32_t ism__near_keys(const ism__near_work *w, uint64_t *keys)
{
    ism__v3 lo = ism__v3_make(1e30f, 1e30f, 1e30f), hi = ism__v3_make(-1e30f, -1e30f, -1e30f), size;
    uint32_t i, count = 0;
    float most;
    for (i = 0; i < w->drawn; i++)
        if (w->out[i].vpl >= 0.0f) {
            lo = ism__v3_min(lo, ism__v3_load(w->out[i].position));
            hi = ism__v3_max(hi, ism__v3_load(w->out[i].position));
        }
    size = ism__v3_sub(hi, lo);
    most = size.x > size.y ? size.x : size.y;
    most = most > size.z ? most : size.z;
    for (i = 0; i < w->drawn; i++)
        if (w->out[i].vpl >= 0.0f) {
            ism__v3 p = ism__v3_sub(ism__v3_load(w->out[i].position), lo);
            uint32_t key;
            if (most > 0.0f) p = ism__v3_scale(p, 1.0f / most);
            p = ism__v3_max(p, ism__v3_make(0.0f, 0.0f, 0.0f));     /* in a box wider than a float p may be no
                                                                       number: it becomes 0 */
            key = ism__spread_bits(ism__texel_of(p.x, 1024u)) |
                  ism__spread_bits(ism__texel_of(p.y, 1024u)) << 1 |
                  ism__spread_bits(ism__texel_of(p.z, 1024u)) << 2;
            keys[count++] = (uint64_t)key << 32 | i;
        }
    return count;
}

/* Sorts keys by their upper halves, in four passes of 8 bits; the result lies where the keys were. */
static void ism__sort_keys(uint64_t *keys, uint64_t *other, uint32_t count)
{
    uint32_t shift, i;
    for (shift = 32u; shift < 64u; shift += 8u) {
        uint32_t starts[257] = { 0 };
        uint64_t *swap = keys;
        for (i = 0; i < count; i++) starts[(keys[i] >> shift & 255u) + 1u]++;
        for (i = 0; i < 256u; i++) starts[i + 1u] += starts[i];
        for (i = 0; i < count; i++) other[starts[keys[i] >> shift & 255u]++] = keys[i];
        keys = other;
        other = swap;
    }
}

/* Writes the centre and radius of a sphere beyond which no point of a block reaches. */
static void ism__near_sphere(const ism_near_point *points, uint32_t count, float sphere[4])
{
    ism__v3 lo = ism__v3_load(points->position), hi = lo, c;
    float most = 0.0f;
    uint32_t i;
    for (i = 1; i < count; i++) {
        lo = ism__v3_min(lo, ism__v3_load(points[i].position));
        hi = ism__v3_max(hi, ism__v3_load(points[i].position));
    }
    c = ism__v3_scale(ism__v3_add(lo, hi), 0.5f);
    for (i = 0; i < count; i++) {
        float d = ism__v3_length(ism__v3_sub(ism__v3_load(points[i].position), c)) + points[i].reach;
        most = d > most ? d : most;
    }
    ism__v3_store(sphere, c);
    sphere[3] = most;
}

static int ism__grow_near(ism_maps *m)
{
    size_t n = m->desc.vpl_count, drawn = n * (size_t)m->desc.near_point_count;
    return !drawn ||
           (ism__grow(m, &m->near_points, drawn, sizeof(ism_near_point)) &&
            ism__grow(m, &m->near_drawn, drawn, sizeof(ism_near_point)) &&
            ism__grow(m, &m->near_keys, 2u * drawn, sizeof(uint64_t)) &&
            ism__grow(m, &m->near_blocks, drawn / ISM__NEAR_BLOCK + 1u, 4u * sizeof(float)));
}

/* Sorts the VPLs that near points may stand for along the longest side of their box. They lie where the
   points' keys are written later. */
static void ism__sort_by_x(ism__near_work *w, uint64_t *keys)
{
    const ism_maps *m = w->m;
    float lo[3] = { 1e30f, 1e30f, 1e30f }, hi[3] = { -1e30f, -1e30f, -1e30f };
    uint32_t i, k, bits;
    for (i = 0; i < m->vpl_count; i++)
        for (k = 0; k < 3u && ism__has_near(&m->vpls[i]); k++) {
            lo[k] = m->vpls[i].position[k] < lo[k] ? m->vpls[i].position[k] : lo[k];
            hi[k] = m->vpls[i].position[k] > hi[k] ? m->vpls[i].position[k] : hi[k];
        }
    for (k = 1; k < 3u; k++)
        if (hi[k] - lo[k] > hi[w->axis] - lo[w->axis]) w->axis = k;
    for (i = 0; i < m->vpl_count; i++)
        if (ism__has_near(&m->vpls[i])) {
            bits = ism__to_bits(m->vpls[i].position[w->axis] + 0.0f);       /* + 0 turns -0 into 0 */
            /* As unsigned numbers, these bits have the order of the floats. */
            bits = bits >> 31 ? ~bits : bits | 0x80000000u;
            keys[w->sorted_count++] = (uint64_t)bits << 32 | i;
        }
    ism__sort_keys(keys, keys + w->drawn, w->sorted_count);
    w->sorted = keys;
}

static ism_result ism__draw_near(ism_maps *m, const ism__job *job, double total, float from, float to)
{
    uint32_t n = m->vpl_count, i, drawn = m->desc.vpl_count * (uint32_t)m->desc.near_point_count;
    ism__near_work w = { m, job, total, NULL, 0, drawn, 0, NULL };
    ism_near_point *points = (ism_near_point *)m->near_points.data;
    uint64_t *keys = (uint64_t *)m->near_keys.data;
    if (!drawn || !(total > 0.0)) return ISM_OK;
    ism__sort_by_x(&w, keys);
    if (w.sorted_count <= ISM__NEAR_RANK) return ISM_OK;
    w.out = (ism_near_point *)m->near_drawn.data;
    if (!ism__run(m, &job->part, from, 0.5f * (from + to), n, ism__reach_task, &w) ||
        !ism__run(m, &job->part, 0.5f * (from + to), to, (drawn + ISM__NEAR_BLOCK - 1u) / ISM__NEAR_BLOCK,
                  ism__near_task, &w))
        return m->chosen = 0, ISM_ERR_CANCELLED;
    m->near_count = m->stats.near_points = ism__near_keys(&w, keys);
    ism__sort_keys(keys, keys + drawn, m->near_count);
    for (i = 0; i < m->near_count; i++) points[i] = w.out[(uint32_t)keys[i]];
    for (i = 0; i < m->near_count; i += ISM__NEAR_BLOCK)
        ism__near_sphere(points + i,
                         m->near_count - i < ISM__NEAR_BLOCK ? m->near_count - i : ISM__NEAR_BLOCK,
                         (float *)m->near_blocks.data + i / ISM__NEAR_BLOCK * 4u);
    return ISM_OK;
}

/* ==== src/ism/choose.h ==== */

/* ---- choose: the stage of section 4, and what it leaves ---- */

/* Makes room for the importances and near points of sources with this many texels. Returns 0 if there is no
   memory. */
static int ism__grow_choice(ism_maps *m, size_t sources, size_t cells, size_t doubles)
{
    return ism__grow(m, &m->sources, sources, sizeof(ism__source_of)) &&
           ism__grow(m, &m->importance, cells, sizeof(float)) &&
           ism__grow(m, &m->blurred, 2u * cells, sizeof(float)) &&
#ifndef ISM_WITHOUT_NEAR_POINTS
           ism__grow(m, &m->cdf, doubles, sizeof(double)) && ism__grow_near(m);
#else
           ism__grow(m, &m->cdf, doubles, sizeof(double));
#endif
}

/* Computes the importances of all sources, up to 0.7 of the call's progress. */
static ism_result ism__weigh_sources(ism_maps *m, const ism__job *job, size_t cells, ism__source_of *of)
{
    const ism_frame *f = job->frame;
    uint32_t seed = m->desc.unstable ? ism__hash_combine(m->desc.seed, f->index) : m->desc.seed;
    size_t s, first = 0, cdf_first = 0;
    ism__choice c;
    memset(&c, 0, sizeof c);
    c.m = m;
    c.job = job;
    c.extent = ism__extent(&job->view);
    c.by_mean = m->desc.importance == ISM_IMPORTANCE_BRSM_MEAN ||
                m->desc.importance == ISM_IMPORTANCE_GUIDED_MEAN;
    m->stats.bad_pvpls = 0;
    m->stats.flux[0] = m->stats.flux[1] = m->stats.flux[2] = 0.0;
    for (s = 0; s < f->source_count; s++) {
        const ism_source *src = &f->sources[s];
        size_t texels = (size_t)src->width * src->height;
        ism_result result;
        c.source = s;
        c.seed = ism__hash_combine(seed, (uint32_t)s);
        c.out = (float *)m->importance.data + first;
        c.lum = (float *)m->blurred.data + first;
        c.effect = c.lum + cells;
        c.from = 0.7f * (float)first / (float)cells;
        c.to = 0.7f * (float)(first + texels) / (float)cells;
        of[s].first = first;
        of[s].cdf_first = cdf_first;
        result = ism__weigh_source(&c, src, &of[s].flux);
        if (result != ISM_OK) return result;
        first += texels;
        cdf_first += ism__cdf2_doubles(src->width, src->height);
    }
    c.out = (float *)m->importance.data;
    c.lum = (float *)m->blurred.data;
    ism__add_shares(&c, of);
    return ISM_OK;
}

/* Makes prefix sums of the importances, and returns the sum of all. */
static double ism__sum_importances(ism_maps *m, const ism_frame *f, ism__source_of *of)
{
    double total = 0.0;
    size_t s;
    for (s = 0; s < f->source_count; s++) {
        const ism_source *src = &f->sources[s];
        ism__cdf2 cdf;
        ism__cdf2_build(&cdf, (double *)m->cdf.data + of[s].cdf_first,
                        (float *)m->importance.data + of[s].first, NULL, src->width, src->height);
        of[s].total = ism__cdf2_total(&cdf);
        total += of[s].total;
    }
    return total;
}

static ism_result ism__choose(ism_maps *m, const ism__job *job)
{
    const ism_frame *f = job->frame;
    ism__source_of *of;
    size_t cells, doubles;
    double total;
    ism_result result = ism__check_sources(&job->log, f, &cells, &doubles);
    if (result != ISM_OK) return result;
    m->source_count = 0;
    if (!ism__grow_choice(m, f->source_count, cells, doubles)) return ism__no_memory(&job->log);
    of = (ism__source_of *)m->sources.data;
    result = ism__weigh_sources(m, job, cells, of);
    if (result != ISM_OK) return m->chosen = 0, result;
    m->source_count = f->source_count;
    m->cells = cells;
    total = ism__sum_importances(m, f, of);
    m->previous_count = m->chosen ? m->vpl_count : 0;
    memcpy(m->previous.data, m->vpls, m->previous_count * sizeof *m->vpls);
    ism__draw_all_vpls(m, job, total);
    ism__flag_jumps(m);
    m->built = 0;
    result = ism__finish_vpls(m, &job->part, 0.7f, 0.8f);
#ifndef ISM_WITHOUT_NEAR_POINTS
    if (result == ISM_OK) return ism__draw_near(m, job, total, 0.8f, 1.0f);
#endif
    return result;
}

/* Begins a call that is given a frame: fills job, and checks the frame's receivers. */
static ism_result ism__open_frame(const ism_maps *m, const ism_frame *f, const char *function, ism__job *job)
{
    if (!m) return ISM_ERR_ARGUMENT;
    ism__begin_job(&m->desc.system, function, f, job);
    if (!f) return ism__is_null(&job->log, "frame");
    return ism__open_view(&job->log, f->points, &job->view);
}

ISM_DEF ism_result ism_choose(ism_maps *m, const ism_frame *f)
{
    ism__job job;
    ism_result result = ism__open_frame(m, f, "ism_choose", &job);
    return result == ISM_OK ? ism__choose(m, &job) : result;
}

/* Logs "vpls[INDEX].FIELD is VALUE; it must be WANTED", and returns ISM_ERR_INPUT. */
static ism_result ism__bad_vpl(const ism__logger *log, size_t index, const char *field, float value,
                               const char *wanted)
{
    ism__message name;
    name.used = 0;
    ism__message_text(&name, "vpls[");
    ism__message_count(&name, index);
    ism__message_text(&name, "].");
    ism__message_text(&name, field);
    ism__log_value(log, name.text, (double)value, wanted);
    return ISM_ERR_INPUT;
}

static ism_result ism__check_vpl(const ism__logger *log, const ism_vpl *v, size_t i)
{
    static const char unit[] = "1 (0.97..1.03)", *const positions[] = { "position[0]", "position[1]",
                                                                        "position[2]" };
    static const char *const fluxes[] = { "flux[0]", "flux[1]", "flux[2]" };
    ism__v3 normal = ism__v3_load(v->normal), axis = ism__v3_load(v->axis);
    int k;
    for (k = 0; k < 3; k++) {
        if (!ism__finite(v->position[k])) return ism__bad_vpl(log, i, positions[k], v->position[k], "finite");
        if (!ism__in(v->flux[k], 0.0f, 1e30f)) return ism__bad_vpl(log, i, fluxes[k], v->flux[k], "0..1e30");
    }
    if (ism__unit_kind(normal) <= 0)
        return ism__bad_vpl(log, i, "normal's length", ism__v3_length(normal), unit);
    if (ism__unit_kind(axis) <= 0) return ism__bad_vpl(log, i, "axis's length", ism__v3_length(axis), unit);
    if (!ism__in(v->exponent, 0.0f, 1e5f)) return ism__bad_vpl(log, i, "exponent", v->exponent, "0..1e5");
    if (!ism__in(v->area, 0.0f, ISM__MAX_FLOAT))
        return ism__bad_vpl(log, i, "area", v->area, "finite and not negative");
    return ISM_OK;
}

ISM_DEF ism_result ism_set_vpls(ism_maps *m, const ism_vpl *vpls, size_t count)
{
    ism__job job;
    size_t i;
    if (!m) return ISM_ERR_ARGUMENT;
    ism__begin_job(&m->desc.system, "ism_set_vpls", NULL, &job);
    if (!vpls && count) return ism__is_null(&job.log, "vpls");
    if (count > m->desc.vpl_count) {
        ism__log_value(&job.log, "count", (double)count, "desc.vpl_count at most");
        return ISM_ERR_LIMIT;
    }
    for (i = 0; i < count; i++) {
        ism_result result = ism__check_vpl(&job.log, &vpls[i], i);
        if (result != ISM_OK) return result;
    }
    if (count) memcpy(m->vpls, vpls, count * sizeof *vpls);
    m->vpl_count = (uint32_t)count;
    m->stats.jumped = 0;
    m->built = 0;
    return ism__finish_vpls(m, &job.part, 0.0f, 1.0f);
}

ISM_DEF const ism_vpl *ism_vpls(const ism_maps *m, size_t *count)
{
    if (count) *count = m ? m->vpl_count : 0;
    return m ? m->vpls : NULL;
}

ISM_DEF const ism_near_point *ism_near_points(const ism_maps *m, size_t *count)
{
    if (count) *count = m ? m->near_count : 0;
    return m && m->near_count ? (const ism_near_point *)m->near_points.data : NULL;
}

ISM_DEF const float *ism_importances(const ism_maps *m, size_t source, size_t *count)
{
    const ism__source_of *of;
    if (!m || !m->chosen || source >= m->source_count) return NULL;
    of = (const ism__source_of *)m->sources.data;
    if (count) *count = (source + 1u < m->source_count ? of[source + 1u].first : m->cells) -
                        of[source].first;
    return (const float *)m->importance.data + of[source].first;
}

/* ==== src/ism/windows.h ==== */

/* ---- windows: most texels of a tile show that part of the square which the picture shows ---- */

/* Sets the map of one axis; below and above are the 64ths of the square on either side of the window. The
   window begins and ends between texels, so that the map is linear within each. */
static void ism__set_axis(uint32_t below, uint32_t above, uint32_t size, uint32_t rim, ism__axis *out)
{
    uint32_t rest = below + above, a;
    memset(out, 0, sizeof *out);
    if (!(rest * size > rim * ISM__STEPS) || rest >= ISM__STEPS) return;
    a = (2u * rim * below + rest) / (2u * rest);
    if (below && !a) a = 1u;
    if (above && a == rim) a = rim - 1u;
    out->on = 1;
    out->lo = (float)below / (float)ISM__STEPS;
    out->hi = (float)(ISM__STEPS - above) / (float)ISM__STEPS;
    out->a = (float)a / (float)size;
    out->b = (float)(size - rim + a) / (float)size;
    out->below = below ? out->a / out->lo : 1.0f;
    out->inside = (out->b - out->a) / (out->hi - out->lo);
    out->above = above ? (1.0f - out->b) / (1.0f - out->hi) : 1.0f;
}

static void ism__set_window(uint32_t window, uint32_t size, uint32_t rim, ism__window *out)
{
    ism__set_axis(window & 63u, window >> 12 & 63u, size, rim, &out->u);
    ism__set_axis(window >> 6 & 63u, window >> 18 & 63u, size, rim, &out->v);
}

static float ism__to_tile(const ism__axis *w, float u)
{
    float x;
    if (!w->on) return u;
    x = u < w->lo ? u * w->below : u < w->hi ? w->a + (u - w->lo) * w->inside : w->b + (u - w->hi) * w->above;
    return x < 0.0f ? 0.0f : x < 1.0f ? x : 1.0f;
}

static float ism__from_tile(const ism__axis *w, float x)
{
    float u;
    if (!w->on) return x;
    u = x < w->a ? x / w->below : x < w->b ? w->lo + (x - w->a) / w->inside : w->hi + (x - w->b) / w->above;
    return u < 0.0f ? 0.0f : u < 1.0f ? u : 1.0f;
}

ISM_DEF void ism_zoom(uint32_t window, uint32_t tile_side, uint32_t rim, const float uv[2], float tile[2])
{
    ism__window w;
    ism__set_window(window, tile_side, rim, &w);
    tile[0] = ism__to_tile(&w.u, uv[0] > 0.0f ? uv[0] < 1.0f ? uv[0] : 1.0f : 0.0f);
    tile[1] = ism__to_tile(&w.v, uv[1] > 0.0f ? uv[1] < 1.0f ? uv[1] : 1.0f : 0.0f);
}

ISM_DEF void ism_unzoom(uint32_t window, uint32_t tile_side, uint32_t rim, const float tile[2], float uv[2])
{
    ism__window w;
    ism__set_window(window, tile_side, rim, &w);
    uv[0] = ism__from_tile(&w.u, tile[0] > 0.0f ? tile[0] < 1.0f ? tile[0] : 1.0f : 0.0f);
    uv[1] = ism__from_tile(&w.v, tile[1] > 0.0f ? tile[1] < 1.0f ? tile[1] : 1.0f : 0.0f);
}

/* ==== src/ism/windows_make.h ==== */

/* ---- windows: where the picture lies in the squares of VPLs ---- */

/* Writes where a place lies in the VPL's square. Returns 0 if the place is not before the VPL, or outside a
   map of directions. */
static int ism__square_of(const ism_maps *m, const ism_vpl *v, const ism__orientation *f, ism__v3 p,
                          float uv[2])
{
    ism__v3 l = ism__to_local(f, ism__v3_sub(p, ism__v3_load(v->directional ? m->center : v->position)));
    float d, direction[3];
    if (v->directional) {
        uv[0] = 0.5f * l.x / m->radius + 0.5f;
        uv[1] = 0.5f * l.y / m->radius + 0.5f;
        return uv[0] >= 0.0f && uv[1] >= 0.0f && uv[0] < 1.0f && uv[1] < 1.0f;
    }
    d = ism__v3_length(l);
    if (!(d > 0.0f) || !ism__finite(d)) return 0;
    ism__v3_store(direction, ism__v3_scale(l, 1.0f / d));
    return ism_map_coordinates(ism__projection_of(m, v), v->exponent, direction, uv);
}

typedef struct ism__window_work {
    ism_maps       *m;
    const ism__view *view;
    uint32_t        rows, columns, count, seen[8u * ISM__SIGHTS];
} ism__window_work;

/* Finds the receivers of one block that lie farthest in eight directions, such as the corners of a wall: a
   window that holds them holds nearly all others. A receiver that was found before is UINT32_MAX. */
static void ism__sight_task(void *context, size_t index)
{
    ism__window_work *w = (ism__window_work *)context;
    const ism__view *view = w->view;
    uint32_t row = (uint32_t)index / w->columns, column = (uint32_t)index % w->columns,
             *best = w->seen + 8u * index;
    uint32_t k, j;
    size_t x, y, x1 = (size_t)view->width * (column + 1u) / w->columns,
                 y1 = (size_t)view->height * (row + 1u) / w->rows;
    float most[8];
    memset(best, 255, 8u * sizeof *best);
    for (y = (size_t)view->height * row / w->rows; y < y1; y++)
        for (x = (size_t)view->width * column / w->columns; x < x1; x++) {
            ism__v3 p, n;
            size_t i = y * view->width + x;
            if (!ism__receiver(view, i, &p, &n)) continue;
            for (k = 0; k < 8u; k++) {      /* unequal weights: no two points of a grid lie equally far */
                float at =
                    (k & 1u ? p.x : -p.x) + 0.9f * (k & 2u ? p.y : -p.y) + 1.1f * (k & 4u ? p.z : -p.z);
                if (best[k] != UINT32_MAX && !(at > most[k])) continue;
                most[k] = at;
                best[k] = (uint32_t)i;
            }
        }
    for (k = 1; k < 8u; k++)
        for (j = 0; j < k; j++)
            if (best[j] == best[k]) best[k] = UINT32_MAX;
}

/* Returns where one side of the new window lies: where it was in the frame before, if that is no more than
   ISM__SLACK farther out than needed, so that windows seldom change while things move; else where it is
   needed. */
static uint32_t ism__cut_at(uint32_t need, uint32_t was, int known)
{
    return known && was <= need && was + ISM__SLACK >= need ? was : need;
}

static void ism__window_task(void *context, size_t index)
{
    const ism__window_work *w = (const ism__window_work *)context;
    ism_maps *m = w->m;
    ism_vpl *v = &m->vpls[index];
    uint32_t *was = (uint32_t *)(void *)((ism__window *)m->windows.data + m->desc.vpl_count) + index;
    float lo[2] = { 1.0f, 1.0f }, hi[2] = { 0.0f, 0.0f };
    uint32_t i, k;
    int known = index < m->window_count && !v->jumped && !m->desc.unstable;
    ism__window *out = (ism__window *)m->windows.data + index;
    ism__orientation f = ism__vpl_axes(m, v);
    v->window = 0;
    for (i = 0; i < w->count; i++) {
        ism__v3 p, n;
        float uv[2];
        if (w->seen[i] == UINT32_MAX || !ism__receiver(w->view, w->seen[i], &p, &n)) continue;
        n = ism__geometric_normal(w->view, w->seen[i], n);
        if (!(ism__v3_dot(n, v->directional ? f.z : ism__v3_sub(p, ism__v3_load(v->position))) < 0.0f) ||
            !ism__square_of(m, v, &f, p, uv))
            continue;
        for (k = 0; k < 2u; k++) {
            lo[k] = uv[k] < lo[k] ? uv[k] : lo[k];
            hi[k] = uv[k] > hi[k] ? uv[k] : hi[k];
        }
    }
    if (lo[0] <= hi[0])             /* else no receiver looks at this map */
        for (k = 0; k < 2u; k++) {
            float pad = (hi[k] - lo[k]) * ISM__PAD;
            uint32_t low = ism__texel_of(lo[k] > pad ? lo[k] - pad : 0.0f, ISM__STEPS);
            uint32_t high = ISM__STEPS - 1u - ism__texel_of(hi[k] + pad, ISM__STEPS);
            v->window |= ism__cut_at(low, *was >> 6u * k & 63u, known) << 6u * k;
            v->window |= ism__cut_at(high, *was >> (6u * k + 12u) & 63u, known) << (6u * k + 12u);
        }
    *was = v->window;
    ism__set_window(v->window, m->desc.tile_side, (uint32_t)m->desc.window_rim, out);
    if (!out->u.on && !out->v.on) v->window = 0;
}

/* Makes the windows of all tiles. Maps for ism_bounce have none: light that bounces on counts, seen or not.
   Returns 0 if the caller cancels. */
static int ism__make_windows(ism_maps *m, const ism__view *view, const ism__part *part)
{
    ism__window_work w;
    w.m = m;
    w.view = view;
    w.rows = view->height < 8u ? 1u : 8u;
    w.columns = ISM__SIGHTS / w.rows;
    w.count = !m->desc.window_rim || m->desc.keep_hits ? 0 : 8u * ISM__SIGHTS;
    if ((w.count && !ism__run(m, part, 0.0f, 0.05f, ISM__SIGHTS, ism__sight_task, &w)) ||
        !ism__run(m, part, 0.05f, 0.1f, m->vpl_count, ism__window_task, &w))
        return 0;
    m->window_count = m->vpl_count;
    return 1;
}

/* ==== src/ism/spread.h ==== */

/* ---- spread: surfels are spread over triangles, and over clusters of them ---- */

enum { ISM__TRIANGLES = 4096,       /* triangles of one task */
       ISM__CLUSTERS = 32768,       /* the most clusters that there are */
       ISM__VIEWS = 8 };            /* the most receivers from which a triangle is looked at */

/* Clusters are successive triangles that are taken together, to estimate what a VPL sees of them: their
   centroid, the mean squared distance from it, their area, and the mean of n n^T over their normals, which
   gives |n . direction| exactly if all normals are equal. Sixteen clusters lie together in arrays, so that
   kernels work on several at a time. */
enum { ISM__BUNDLE = 16 };
typedef struct ism__clusters {
    float at[3][ISM__BUNDLE], radius2[ISM__BUNDLE], area[ISM__BUNDLE];
    float n[6][ISM__BUNDLE];        /* xx, yy, zz, yz, zx, xy */
} ism__clusters;

struct ism__spread_work;

/* Writes for each cluster about which share of the VPL's map it fills. */
typedef void (*ism__cluster_kernel)(const struct ism__spread_work *w, const ism_vpl *v, float *effect);

/* Returns the mean solid angle of a triangle from `count` receivers, ISM__VIEWS at most, whose positions are
   in views. normal2 is the cross product of its edges. */
typedef float (*ism__triangle_kernel)(const ism__v3 p[3], ism__v3 normal2,
                                      const float views[3][ISM__VIEWS], uint32_t count);

typedef struct ism__spread_work {
    ism_maps        *m;
    const ism_mesh  *mesh;
    const ism__view *view;
    const uint32_t  *valid;         /* pixels that are no background */
    uint32_t         valid_count;
    float           *area, *solid;  /* of each triangle */
    size_t           triangles;
    uint32_t         frame, period;
    int              fresh, fewer;  /* there are no points yet; there were more triangles */
    ism__cdf         cdf;
    ism__clusters   *clusters;
    double          *seen;          /* each cluster's share of all points by what the view sees */
    uint32_t         cluster_count;
    uint32_t         cluster_size;  /* triangles of each cluster but the last */
    ism__cluster_kernel  weigh_clusters;
    ism__triangle_kernel mean_solid_angle;
} ism__spread_work;

/* ==== src/ism/tile.h ==== */

/* ---- tile: one VPL's map while it is drawn, and the discs that are drawn into it ---- */

/* The points of one tile that are set up together, in arrays of one float each, so that kernels work on
   several at a time. `place` reads the fields up to b1 and b2, which it also overwrites, and writes the
   others. */
typedef struct ism__discs {
    uint32_t count;                             /* points in use */
    uint32_t triangle[ISM__DISCS];
    float    corners[3][3][ISM__DISCS];         /* of the triangles: corner, then coordinate */
    float    weight[ISM__DISCS];                /* area that the point stands for, over its triangle's */
    float    b1[ISM__DISCS], b2[ISM__DISCS];    /* barycentric coordinates of the point; 0 if the disc is not
                                                   cut off at its triangle's edges */
    float    d1[3][ISM__DISCS], d2[3][ISM__DISCS];  /* gradients of these coordinates, in the tile's axes */
    float    at[3][ISM__DISCS];                 /* the disc's centre, in the tile's axes */
    float    g[3][ISM__DISCS];                  /* the disc's plane, as in ism__texel */
    float    radius2[ISM__DISCS];
    int32_t  box[4][ISM__DISCS];                /* first and last column, first and last row */
} ism__discs;

typedef struct ism__tile {          /* one VPL's map while it is drawn */
    const ism_maps  *m;
    const ism_mesh  *mesh;
    const ism_vpl   *vpl;
    ism__orientation axes;
    ism_projection   projection;
    uint32_t         size;
    const ism__window *window;      /* NULL: the whole square */
    const float     *x, *y, *z;     /* directions of texel centres, in the tile's axes; in maps of directions
                                       x and y in units of the radius, and 1 */
    float           *depth;         /* at texel centres; ISM_FAR = empty */
    ism__texel      *texels;
    float            texels_per_unit;   /* the most texels of a radian along a side of the square, without
                                           a window; in maps of directions those of a unit of length */
    uint64_t         splats, wide, filled;
} ism__tile;

typedef struct ism__splat {         /* kernels of one instruction set */
    uint32_t (*place)(ism__tile *tile, ism__discs *s);
    /* Finds where discs lie in the tile. Returns a bit for each disc that may cover a texel. */
    void     (*draw)(ism__tile *tile, const ism__discs *s, uint32_t bits);
    /* Draws the discs whose bits are set, one after the other. */
} ism__splat;

/* Returns the depth of the surfel's plane at a texel; 0 if the texel's ray does not meet the plane. */
static float ism__plane_depth(const ism__tile *tile, const float g[3], size_t i)
{
    float s = g[0] * tile->x[i] + g[1] * tile->y[i] + g[2] * tile->z[i];
    if (tile->vpl->directional) return s > 0.0f ? s : 0.0f;
    return s > 1e-20f ? 1.0f / s : 0.0f;
}

/* Returns ism__tile's texels_per_unit, by its projection. */
static float ism__texels_per_unit(const ism__tile *tile)
{
    float size = (float)tile->size;
    if (tile->vpl->directional) return 0.5f * size / tile->m->radius;
    if (tile->projection == ISM_PROJECTION_PARABOLOID) return 0.5f * size;
    if (tile->projection == ISM_PROJECTION_LOBE)
        return 0.9f * size * sqrtf(0.5f * (tile->vpl->exponent + 1.0f));
    return 0.9f * size;
}

/* ==== src/ism/kernels_begin.h ==== */

/* ---- kernels: one text, compiled for every instruction set ---- */

/* Every instruction set has its own functions of these names, see unit simd. */
#define ism__lanes3_cross ISM__NAME_IN_SET(ism__lanes3_cross, ISM__SET)
#define ism__lanes3_madd ISM__NAME_IN_SET(ism__lanes3_madd, ISM__SET)
#define ism__lanes3_turn ISM__NAME_IN_SET(ism__lanes3_turn, ISM__SET)
#define ism__lanes3_select ISM__NAME_IN_SET(ism__lanes3_select, ISM__SET)
#define ism__lanes3_store ISM__NAME_IN_SET(ism__lanes3_store, ISM__SET)
#define ism__lanes_to_tile ISM__NAME_IN_SET(ism__lanes_to_tile, ISM__SET)
#define ism__square_of_disc ISM__NAME_IN_SET(ism__square_of_disc, ISM__SET)
#define ism__stretch_to_lobe ISM__NAME_IN_SET(ism__stretch_to_lobe, ISM__SET)
#define ism__sizes ISM__NAME_IN_SET(ism__sizes, ISM__SET)
#define ism__places ISM__NAME_IN_SET(ism__places, ISM__SET)
#define ism__project ISM__NAME_IN_SET(ism__project, ISM__SET)
#define ism__span_axis ISM__NAME_IN_SET(ism__span_axis, ISM__SET)
#define ism__cut_at_edges ISM__NAME_IN_SET(ism__cut_at_edges, ISM__SET)
#define ism__before_sky ISM__NAME_IN_SET(ism__before_sky, ISM__SET)
#define ism__before_vpl ISM__NAME_IN_SET(ism__before_vpl, ISM__SET)
#define ism__place_some ISM__NAME_IN_SET(ism__place_some, ISM__SET)
#define ism__place_discs ISM__NAME_IN_SET(ism__place_discs, ISM__SET)
#define ism__texels_hit ISM__NAME_IN_SET(ism__texels_hit, ISM__SET)
#define ism__draw_disc ISM__NAME_IN_SET(ism__draw_disc, ISM__SET)
#define ism__draw_discs ISM__NAME_IN_SET(ism__draw_discs, ISM__SET)
#define ism__mean_solid_angle ISM__NAME_IN_SET(ism__mean_solid_angle, ISM__SET)

#define ISM__SET plain
#define ISM__WIDTH ISM__SIMD_WIDTH
#define ISM__LANE_COUNT 8

#endif /* !ISM_IMPLEMENTED */

#ifdef ISM__SET
#if ISM_VERSION != 900 /* this file's: another one that includes it as ISM_FILE has its own */
#error "ism.h: the file that ISM_FILE names is of another version than the one that includes it"
#endif

/* ==== src/shared/simd_begin.h ==== */

/* unit simd_begin, needs simd: what the kernels of one instruction set are compiled with */

#undef ISM__KERNEL
#undef ISM__IN_KERNEL
#undef ISM__IN_LARGE_KERNEL
#undef ISM__INTEL
#undef ISM__EACH

#if ISM__WIDTH == 16
#define ISM__KERNEL ISM__TARGET_AVX512
#elif ISM__WIDTH == 8
#define ISM__KERNEL ISM__TARGET_AVX2
#else
#define ISM__KERNEL
#endif

#if ISM__WIDTH == 16
#define ISM__INTEL(name) _mm512_##name
#elif ISM__WIDTH == 8
#define ISM__INTEL(name) _mm256_##name
#else
#define ISM__INTEL(name) _mm_##name
#endif

/* ISM__IN_LARGE_KERNEL stands after `static`, before a function that a kernel calls dozens of times. Such a
   function is not inlined without optimisation, nor with gcc's sanitizers, which take minutes to build large
   functions. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define ISM__IN_KERNEL __attribute__((always_inline)) ISM__KERNEL
#else
#define ISM__IN_KERNEL ISM__KERNEL
#endif
#if defined(__GNUC__) && !defined(__TINYC__) && (!defined(__OPTIMIZE__) || defined(__SANITIZE_ADDRESS__))
#define ISM__IN_LARGE_KERNEL __attribute__((noinline)) ISM__KERNEL
#else
#define ISM__IN_LARGE_KERNEL inline ISM__IN_KERNEL
#endif

/* ISM__EACH executes statements for every piece of ISM__WIDTH lanes. The number of the piece is a constant in
   them, so that compilers keep pieces in registers. */
#if ISM__WIDTH > 1 && ISM__LANE_COUNT == ISM__WIDTH
#define ISM__EACH(...) { enum { piece = 0 }; __VA_ARGS__; }
#elif ISM__WIDTH > 1 && ISM__LANE_COUNT == 2 * ISM__WIDTH
#define ISM__EACH(...) { enum { piece = 0 }; __VA_ARGS__; } { enum { piece = 1 }; __VA_ARGS__; }
#elif ISM__WIDTH > 1 && ISM__LANE_COUNT == 4 * ISM__WIDTH
#define ISM__EACH(...) \
    { enum { piece = 0 }; __VA_ARGS__; } { enum { piece = 1 }; __VA_ARGS__; } \
    { enum { piece = 2 }; __VA_ARGS__; } { enum { piece = 3 }; __VA_ARGS__; }
#else
#define ISM__EACH(...) \
    { int piece; for (piece = 0; piece < ISM__LANE_COUNT / ISM__WIDTH; piece++) { __VA_ARGS__; } }
#endif

/* ==== src/shared/simd_x86.h ==== */

/* unit simd_x86, needs simd_begin: lanes of SSE2, AVX2 and AVX-512 */

#if ISM__SIMD_X86 || ISM__WIDTH > 4

#if ISM__WIDTH == 16
typedef struct ism__lanes { __m512 v[ISM__LANE_COUNT / 16]; } ism__lanes;
typedef struct ism__lane_ints { __m512i v[ISM__LANE_COUNT / 16]; } ism__lane_ints;
typedef struct ism__lane_mask { __mmask16 v[ISM__LANE_COUNT / 16]; } ism__lane_mask;
#elif ISM__WIDTH == 8
typedef struct ism__lanes { __m256 v[ISM__LANE_COUNT / 8]; } ism__lanes;
typedef struct ism__lane_ints { __m256i v[ISM__LANE_COUNT / 8]; } ism__lane_ints;
typedef struct ism__lane_mask { __m256 v[ISM__LANE_COUNT / 8]; } ism__lane_mask;
#else
typedef struct ism__lanes { __m128 v[ISM__LANE_COUNT / 4]; } ism__lanes;
typedef struct ism__lane_ints { __m128i v[ISM__LANE_COUNT / 4]; } ism__lane_ints;
typedef struct ism__lane_mask { __m128 v[ISM__LANE_COUNT / 4]; } ism__lane_mask;
#endif

static inline ISM__IN_KERNEL ism__lanes ism__lanes_load(const float *from)
{
    ism__lanes a;
    ISM__EACH(a.v[piece] = ISM__INTEL(loadu_ps)(from + piece * ISM__WIDTH))
    return a;
}

static inline ISM__IN_KERNEL void ism__lanes_store(float *to, ism__lanes a)
{
    ISM__EACH(ISM__INTEL(storeu_ps)(to + piece * ISM__WIDTH, a.v[piece]))
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_all(float x)
{
    ism__lanes a;
    ISM__EACH(a.v[piece] = ISM__INTEL(set1_ps)(x))
    return a;
}

/* Comparisons with what is not a number are false, but for differ, which is true. */
static inline ISM__IN_KERNEL ism__lane_mask ism__lanes_greater(ism__lanes a, ism__lanes b)
{
    ism__lane_mask m;
#if ISM__WIDTH == 16
    ISM__EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_GT_OQ))
#elif ISM__WIDTH == 8
    ISM__EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_GT_OQ))
#else
    ISM__EACH(m.v[piece] = _mm_cmpgt_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

static inline ISM__IN_KERNEL ism__lane_mask ism__lanes_at_least(ism__lanes a, ism__lanes b)
{
    ism__lane_mask m;
#if ISM__WIDTH == 16
    ISM__EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_GE_OQ))
#elif ISM__WIDTH == 8
    ISM__EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_GE_OQ))
#else
    ISM__EACH(m.v[piece] = _mm_cmpge_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

/* Returns m ? a : b in each lane. */
static inline ISM__IN_KERNEL ism__lanes ism__lanes_select(ism__lane_mask m, ism__lanes a,
                                                 ism__lanes b)
{
#if ISM__WIDTH == 16
    ISM__EACH(a.v[piece] = _mm512_mask_mov_ps(b.v[piece], m.v[piece], a.v[piece]))
#elif ISM__WIDTH == 8
    ISM__EACH(a.v[piece] = _mm256_blendv_ps(b.v[piece], a.v[piece], m.v[piece]))
#else
    ISM__EACH(a.v[piece] = _mm_or_ps(_mm_and_ps(m.v[piece], a.v[piece]), _mm_andnot_ps(m.v[piece], b.v[piece])))
#endif
    return a;
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_add(ism__lanes a, ism__lanes b)
{
    ISM__EACH(a.v[piece] = ISM__INTEL(add_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_sub(ism__lanes a, ism__lanes b)
{
    ISM__EACH(a.v[piece] = ISM__INTEL(sub_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_mul(ism__lanes a, ism__lanes b)
{
    ISM__EACH(a.v[piece] = ISM__INTEL(mul_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_div(ism__lanes a, ism__lanes b)
{
    ISM__EACH(a.v[piece] = ISM__INTEL(div_ps)(a.v[piece], b.v[piece]))
    return a;
}

/* Returns a > b ? a : b, so that b is the answer if one is not a number. */
static inline ISM__IN_KERNEL ism__lanes ism__lanes_max(ism__lanes a, ism__lanes b)
{
#if ISM__WIDTH == 16                           /* gcc 12 warns of what max without a mask calls */
    ISM__EACH(a.v[piece] = _mm512_maskz_max_ps((__mmask16)0xffff, a.v[piece], b.v[piece]))
#else
    ISM__EACH(a.v[piece] = ISM__INTEL(max_ps)(a.v[piece], b.v[piece]))
#endif
    return a;
}

/* Returns a < b ? a : b. */
static inline ISM__IN_KERNEL ism__lanes ism__lanes_min(ism__lanes a, ism__lanes b)
{
#if ISM__WIDTH == 16                           /* gcc 12 warns of what min without a mask calls */
    ISM__EACH(a.v[piece] = _mm512_maskz_min_ps((__mmask16)0xffff, a.v[piece], b.v[piece]))
#else
    ISM__EACH(a.v[piece] = ISM__INTEL(min_ps)(a.v[piece], b.v[piece]))
#endif
    return a;
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_sqrt(ism__lanes a)
{
#if ISM__WIDTH == 16
    ISM__EACH(a.v[piece] = _mm512_maskz_sqrt_ps((__mmask16)0xffff, a.v[piece]))
#else
    ISM__EACH(a.v[piece] = ISM__INTEL(sqrt_ps)(a.v[piece]))
#endif
    return a;
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_abs(ism__lanes a)
{
    ISM__EACH(a.v[piece] = ISM__INTEL(andnot_ps)(ISM__INTEL(set1_ps)(-0.0f), a.v[piece]))
    return a;
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_negate(ism__lanes a)
{
    ISM__EACH(a.v[piece] = ISM__INTEL(xor_ps)(ISM__INTEL(set1_ps)(-0.0f), a.v[piece]))
    return a;
}

/* Returns m ? a : 0. */
static inline ISM__IN_KERNEL ism__lanes ism__lanes_keep(ism__lane_mask m, ism__lanes a)
{
#if ISM__WIDTH == 16
    ISM__EACH(a.v[piece] = _mm512_maskz_mov_ps(m.v[piece], a.v[piece]))
#else
    ISM__EACH(a.v[piece] = ISM__INTEL(and_ps)(m.v[piece], a.v[piece]))
#endif
    return a;
}

/* Rounds towards 0. An int32_t must be able to hold each float. */
static inline ISM__IN_KERNEL ism__lane_ints ism__lanes_truncate(ism__lanes a)
{
    ism__lane_ints k;
#if ISM__WIDTH == 16
    ISM__EACH(k.v[piece] = _mm512_maskz_cvttps_epi32((__mmask16)0xffff, a.v[piece]))
#else
    ISM__EACH(k.v[piece] = ISM__INTEL(cvttps_epi32)(a.v[piece]))
#endif
    return k;
}

static inline ISM__IN_KERNEL ism__lane_mask ism__mask_and(ism__lane_mask m, ism__lane_mask n)
{
#if ISM__WIDTH == 16
    ISM__EACH(m.v[piece] = (__mmask16)(m.v[piece] & n.v[piece]))
#else
    ISM__EACH(m.v[piece] = ISM__INTEL(and_ps)(m.v[piece], n.v[piece]))
#endif
    return m;
}

/* Returns the mask as bits: bit l is that of lane l. */
static inline ISM__IN_KERNEL uint32_t ism__mask_bits(ism__lane_mask m)
{
    uint32_t bits = 0;
#if ISM__WIDTH == 16
    ISM__EACH(bits |= (uint32_t)m.v[piece] << piece * ISM__WIDTH)
#else
    ISM__EACH(bits |= (uint32_t)ISM__INTEL(movemask_ps)(m.v[piece]) << piece * ISM__WIDTH)
#endif
    return bits;
}

static inline ISM__IN_KERNEL ism__lane_mask ism__mask_of_bits(uint32_t bits)
{
    ism__lane_mask m;
#if ISM__WIDTH == 16
    ISM__EACH(m.v[piece] = (__mmask16)(bits >> piece * ISM__WIDTH))
#elif ISM__WIDTH == 8
    const __m256i each = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    ISM__EACH(
        __m256i k = _mm256_and_si256(_mm256_set1_epi32((int32_t)(bits >> piece * ISM__WIDTH)), each);
        m.v[piece] = _mm256_castsi256_ps(_mm256_cmpeq_epi32(k, each)))
#else
    const __m128i each = _mm_setr_epi32(1, 2, 4, 8);
    ISM__EACH(
        __m128i k = _mm_and_si128(_mm_set1_epi32((int32_t)(bits >> piece * ISM__WIDTH)), each);
        m.v[piece] = _mm_castsi128_ps(_mm_cmpeq_epi32(k, each)))
#endif
    return m;
}

static inline ISM__IN_KERNEL void ism__ints_store(int32_t *to, ism__lane_ints k)
{
#if ISM__WIDTH == 16
    ISM__EACH(_mm512_storeu_si512((void *)(to + piece * ISM__WIDTH), k.v[piece]))
#elif ISM__WIDTH == 8
    ISM__EACH(_mm256_storeu_si256((__m256i *)(void *)(to + piece * ISM__WIDTH), k.v[piece]))
#else
    ISM__EACH(_mm_storeu_si128((__m128i *)(void *)(to + piece * ISM__WIDTH), k.v[piece]))
#endif
}

#endif

/* ==== src/shared/simd_plain.h ==== */

/* unit simd_plain, needs simd_begin: lanes of NEON, WebAssembly and others, or floats one by one */

#if !ISM__SIMD_X86 && ISM__WIDTH <= 4

#if ISM__SIMD_VECTORS
typedef float ism__piece __attribute__((vector_size(16)));
typedef int32_t ism__piece_ints __attribute__((vector_size(16)));
typedef uint32_t ism__piece_words __attribute__((vector_size(16)));
#else
typedef float ism__piece;
typedef int32_t ism__piece_ints;
typedef uint32_t ism__piece_words;
#endif
typedef struct ism__lanes { ism__piece v[ISM__LANE_COUNT / ISM__WIDTH]; } ism__lanes;
typedef struct ism__lane_ints { ism__piece_ints v[ISM__LANE_COUNT / ISM__WIDTH]; } ism__lane_ints;
/* Lanes of 0 or -1. */
typedef struct ism__lane_mask { ism__piece_ints v[ISM__LANE_COUNT / ISM__WIDTH]; } ism__lane_mask;

static inline ISM__IN_KERNEL ism__lanes ism__lanes_load(const float *from)
{
    ism__lanes a;
    ISM__EACH(memcpy(&a.v[piece], from + piece * ISM__WIDTH, sizeof a.v[piece]))
    return a;
}

static inline ISM__IN_KERNEL void ism__lanes_store(float *to, ism__lanes a)
{
    ISM__EACH(memcpy(to + piece * ISM__WIDTH, &a.v[piece], sizeof a.v[piece]))
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_all(float x)
{
    ism__lanes a;
#if ISM__SIMD_VECTORS
    const ism__piece all = { x, x, x, x };
    ISM__EACH(a.v[piece] = all)
#else
    ISM__EACH(a.v[piece] = x)
#endif
    return a;
}

/* Comparisons with what is not a number are false, but for differ, which is true. */
static inline ISM__IN_KERNEL ism__lane_mask ism__lanes_greater(ism__lanes a, ism__lanes b)
{
    ism__lane_mask m;
#if ISM__SIMD_VECTORS
    ISM__EACH(m.v[piece] = a.v[piece] > b.v[piece])
#else
    ISM__EACH(m.v[piece] = -(a.v[piece] > b.v[piece]))
#endif
    return m;
}

static inline ISM__IN_KERNEL ism__lane_mask ism__lanes_at_least(ism__lanes a, ism__lanes b)
{
    ism__lane_mask m;
#if ISM__SIMD_VECTORS
    ISM__EACH(m.v[piece] = a.v[piece] >= b.v[piece])
#else
    ISM__EACH(m.v[piece] = -(a.v[piece] >= b.v[piece]))
#endif
    return m;
}

/* Returns m ? a : b in each lane. */
static inline ISM__IN_KERNEL ism__lanes ism__lanes_select(ism__lane_mask m, ism__lanes a,
                                                 ism__lanes b)
{
#if ISM__SIMD_VECTORS
    ISM__EACH(a.v[piece] = (ism__piece)((m.v[piece] & (ism__piece_ints)a.v[piece]) |
                                  (~m.v[piece] & (ism__piece_ints)b.v[piece])))
#else
    ISM__EACH(a.v[piece] = m.v[piece] ? a.v[piece] : b.v[piece])
#endif
    return a;
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_add(ism__lanes a, ism__lanes b)
{
    ISM__EACH(a.v[piece] = a.v[piece] + b.v[piece])
    return a;
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_sub(ism__lanes a, ism__lanes b)
{
    ISM__EACH(a.v[piece] = a.v[piece] - b.v[piece])
    return a;
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_mul(ism__lanes a, ism__lanes b)
{
    ISM__EACH(a.v[piece] = a.v[piece] * b.v[piece])
    return a;
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_div(ism__lanes a, ism__lanes b)
{
    ISM__EACH(a.v[piece] = a.v[piece] / b.v[piece])
    return a;
}

/* Returns a > b ? a : b, so that b is the answer if one is not a number. */
static inline ISM__IN_KERNEL ism__lanes ism__lanes_max(ism__lanes a, ism__lanes b)
{
    return ism__lanes_select(ism__lanes_greater(a, b), a, b);
}

/* Returns a < b ? a : b. */
static inline ISM__IN_KERNEL ism__lanes ism__lanes_min(ism__lanes a, ism__lanes b)
{
    return ism__lanes_select(ism__lanes_greater(b, a), a, b);
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_sqrt(ism__lanes a)
{
#if ISM__SIMD_VECTORS
#if defined(__aarch64__) && !defined(ISM__NO_SIMD)
    ISM__EACH(a.v[piece] = (ism__piece)vsqrtq_f32((float32x4_t)a.v[piece]))
#elif defined(__wasm_simd128__) && !defined(ISM__NO_SIMD)
    ISM__EACH(a.v[piece] = (ism__piece)wasm_f32x4_sqrt((v128_t)a.v[piece]))
#else
    int k;
    ISM__EACH(for (k = 0; k < 4; k++) a.v[piece][k] = sqrtf(a.v[piece][k]))
#endif
#else
    ISM__EACH(a.v[piece] = sqrtf(a.v[piece]))
#endif
    return a;
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_abs(ism__lanes a)
{
#if ISM__SIMD_VECTORS
    const int32_t b = 0x7fffffff;
    const ism__piece_ints bits = { b, b, b, b };
    ISM__EACH(a.v[piece] = (ism__piece)((ism__piece_ints)a.v[piece] & bits))
#else
    ISM__EACH(a.v[piece] = fabsf(a.v[piece]))
#endif
    return a;
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes_negate(ism__lanes a)
{
    ISM__EACH(a.v[piece] = -a.v[piece])
    return a;
}

/* Returns m ? a : 0. */
static inline ISM__IN_KERNEL ism__lanes ism__lanes_keep(ism__lane_mask m, ism__lanes a)
{
#if ISM__SIMD_VECTORS
    ISM__EACH(a.v[piece] = (ism__piece)(m.v[piece] & (ism__piece_ints)a.v[piece]))
#else
    ISM__EACH(a.v[piece] = m.v[piece] ? a.v[piece] : 0.0f)
#endif
    return a;
}

/* Rounds towards 0. An int32_t must be able to hold each float. */
static inline ISM__IN_KERNEL ism__lane_ints ism__lanes_truncate(ism__lanes a)
{
    ism__lane_ints k;
#if ISM__SIMD_VECTORS
    ISM__EACH(k.v[piece] = __builtin_convertvector(a.v[piece], ism__piece_ints))
#else
    ISM__EACH(k.v[piece] = (int32_t)a.v[piece])
#endif
    return k;
}

static inline ISM__IN_KERNEL ism__lane_mask ism__mask_and(ism__lane_mask m, ism__lane_mask n)
{
    ISM__EACH(m.v[piece] = m.v[piece] & n.v[piece])
    return m;
}

/* Returns the mask as bits: bit l is that of lane l. */
static inline ISM__IN_KERNEL uint32_t ism__mask_bits(ism__lane_mask m)
{
    uint32_t bits = 0;
#if ISM__SIMD_VECTORS
    int k;
    ISM__EACH(for (k = 0; k < 4; k++) bits |= ((uint32_t)m.v[piece][k] & 1u) << (piece * ISM__WIDTH + k))
#else
    ISM__EACH(bits |= ((uint32_t)m.v[piece] & 1u) << piece)
#endif
    return bits;
}

static inline ISM__IN_KERNEL ism__lane_mask ism__mask_of_bits(uint32_t bits)
{
    ism__lane_mask m;
#if ISM__SIMD_VECTORS
    const ism__piece_ints each = { 1, 2, 4, 8 };
    ISM__EACH(
        const int32_t own = (int32_t)(bits >> piece * ISM__WIDTH & 15u);
        const ism__piece_ints all = { own, own, own, own };
        m.v[piece] = (all & each) == each)
#else
    ISM__EACH(m.v[piece] = -(int32_t)(bits >> piece & 1u))
#endif
    return m;
}

static inline ISM__IN_KERNEL void ism__ints_store(int32_t *to, ism__lane_ints k)
{
    ISM__EACH(memcpy(to + piece * ISM__WIDTH, &k.v[piece], sizeof k.v[piece]))
}

#endif

/* ==== src/shared/simd_lanes3.h ==== */

/* unit simd_lanes3, needs simd_begin: vectors of three in lanes */

typedef struct ism__lanes3 { ism__lanes x, y, z; } ism__lanes3;

static inline ISM__IN_KERNEL ism__lanes3 ism__lanes3_load(const float *x, const float *y, const float *z)
{
    ism__lanes3 a;
    a.x = ism__lanes_load(x);
    a.y = ism__lanes_load(y);
    a.z = ism__lanes_load(z);
    return a;
}

static inline ISM__IN_KERNEL ism__lanes3 ism__lanes3_all(float x, float y, float z)
{
    ism__lanes3 a;
    a.x = ism__lanes_all(x);
    a.y = ism__lanes_all(y);
    a.z = ism__lanes_all(z);
    return a;
}

static inline ISM__IN_KERNEL ism__lanes3 ism__lanes3_sub(ism__lanes3 a, ism__lanes3 b)
{
    a.x = ism__lanes_sub(a.x, b.x);
    a.y = ism__lanes_sub(a.y, b.y);
    a.z = ism__lanes_sub(a.z, b.z);
    return a;
}

static inline ISM__IN_KERNEL ism__lanes3 ism__lanes3_scale(ism__lanes3 a, ism__lanes s)
{
    a.x = ism__lanes_mul(a.x, s);
    a.y = ism__lanes_mul(a.y, s);
    a.z = ism__lanes_mul(a.z, s);
    return a;
}

static inline ISM__IN_KERNEL ism__lanes ism__lanes3_dot(ism__lanes3 a, ism__lanes3 b)
{
    return ism__lanes_add(ism__lanes_add(ism__lanes_mul(a.x, b.x), ism__lanes_mul(a.y, b.y)),
                       ism__lanes_mul(a.z, b.z));
}

/* ==== src/shared/simd_ints.h ==== */

/* unit simd_ints, needs simd_begin bits: whole numbers in lanes, lanes of a mask in a row, single bits */
#define ism__mask_count ISM__NAME_IN_SET(ism__mask_count, ISM__SET)
#define ism__first_bit ISM__NAME_IN_SET(ism__first_bit, ISM__SET)

/* Returns how many lanes are in a mask. */
static inline ISM__IN_KERNEL uint32_t ism__mask_count(ism__lane_mask m)
{
#if ISM__WIDTH > 4
    return (uint32_t)_mm_popcnt_u32(ism__mask_bits(m));
#else
    return ism__popcount(ism__mask_bits(m));
#endif
}

/* Returns the number of the lowest set bit; bits is not 0. */
static inline ISM__IN_KERNEL uint32_t ism__first_bit(uint32_t bits)
{
#if ISM__WIDTH > 4
    return _tzcnt_u32(bits);
#elif defined(__GNUC__) && !defined(__TINYC__)
    return (uint32_t)__builtin_ctz(bits);
#else
    return ism__popcount(~bits & (bits - 1u));
#endif
}

/* ==== src/ism/kernels_project.h ==== */

/* ---- kernels: places of directions in a tile, by ism_map_coordinates and ism__to_tile ---- */

static inline ISM__IN_KERNEL ism__lanes3 ism__lanes3_cross(ism__lanes3 a, ism__lanes3 b)
{
    ism__lanes3 c;
    c.x = ism__lanes_sub(ism__lanes_mul(a.y, b.z), ism__lanes_mul(a.z, b.y));
    c.y = ism__lanes_sub(ism__lanes_mul(a.z, b.x), ism__lanes_mul(a.x, b.z));
    c.z = ism__lanes_sub(ism__lanes_mul(a.x, b.y), ism__lanes_mul(a.y, b.x));
    return c;
}

/* Returns a + b s. */
static inline ISM__IN_KERNEL ism__lanes3 ism__lanes3_madd(ism__lanes3 a, ism__lanes3 b, ism__lanes s)
{
    a.x = ism__lanes_add(a.x, ism__lanes_mul(b.x, s));
    a.y = ism__lanes_add(a.y, ism__lanes_mul(b.y, s));
    a.z = ism__lanes_add(a.z, ism__lanes_mul(b.z, s));
    return a;
}

/* Returns vectors in the axes of an orientation. */
static inline ISM__IN_KERNEL ism__lanes3 ism__lanes3_turn(const ism__orientation *f, ism__lanes3 v)
{
    ism__lanes3 out;
    out.x = ism__lanes3_dot(ism__lanes3_all(f->x.x, f->x.y, f->x.z), v);
    out.y = ism__lanes3_dot(ism__lanes3_all(f->y.x, f->y.y, f->y.z), v);
    out.z = ism__lanes3_dot(ism__lanes3_all(f->z.x, f->z.y, f->z.z), v);
    return out;
}

/* Returns m ? a : b. */
static inline ISM__IN_KERNEL ism__lanes3 ism__lanes3_select(ism__lane_mask m, ism__lanes3 a, ism__lanes3 b)
{
    a.x = ism__lanes_select(m, a.x, b.x);
    a.y = ism__lanes_select(m, a.y, b.y);
    a.z = ism__lanes_select(m, a.z, b.z);
    return a;
}

/* Writes three arrays, from element l on. */
static inline ISM__IN_KERNEL void ism__lanes3_store(float (*to)[ISM__DISCS], size_t l, ism__lanes3 a)
{
    ism__lanes_store(to[0] + l, a.x);
    ism__lanes_store(to[1] + l, a.y);
    ism__lanes_store(to[2] + l, a.z);
}

/* Places in the square, or in the tile. */
typedef struct ism__places { ism__lanes u, v; } ism__places;

/* Does for lanes what ism__to_tile does, for an axis that is on. */
static inline ISM__IN_KERNEL ism__lanes ism__lanes_to_tile(const ism__axis *w, ism__lanes u)
{
    const ism__lanes lo = ism__lanes_all(w->lo), hi = ism__lanes_all(w->hi), zero = ism__lanes_all(0.0f);
    const ism__lanes below = ism__lanes_mul(u, ism__lanes_all(w->below));
    const ism__lanes inside = ism__lanes_add(
        ism__lanes_all(w->a), ism__lanes_mul(ism__lanes_sub(u, lo), ism__lanes_all(w->inside)));
    const ism__lanes above = ism__lanes_add(
        ism__lanes_all(w->b), ism__lanes_mul(ism__lanes_sub(u, hi), ism__lanes_all(w->above)));
    ism__lanes x = ism__lanes_select(ism__lanes_greater(hi, u), inside, above);
    x = ism__lanes_select(ism__lanes_greater(lo, u), below, x);
    return ism__lanes_min(ism__lanes_max(x, zero), ism__lanes_all(1.0f));
}

/* Does for lanes what ism__disc_to_square does. The angle from the nearer axis of the disc is within 45
   degrees, so the part of ism__atan2 for 0 <= |y| <= x is enough. */
static inline ISM__IN_KERNEL ism__places ism__square_of_disc(ism__lanes x, ism__lanes y)
{
    const ism__lanes zero = ism__lanes_all(0.0f), one = ism__lanes_all(1.0f);
    const ism__lanes radius = ism__lanes_sqrt(ism__lanes_add(ism__lanes_mul(x, x), ism__lanes_mul(y, y)));
    const ism__lane_mask wide = ism__lanes_greater(ism__lanes_abs(x), ism__lanes_abs(y));
    const ism__lanes major = ism__lanes_select(wide, x, y), minor = ism__lanes_select(wide, y, x);
    const ism__lane_mask back = ism__lanes_greater(zero, major);
    const ism__lanes length = ism__lanes_abs(major);
    const ism__lane_mask some = ism__lanes_greater(length, zero);
    const ism__lanes a = ism__lanes_div(ism__lanes_abs(minor), ism__lanes_select(some, length, one));
    const ism__lane_mask big = ism__lanes_greater(a, ism__lanes_all(0.414213562f));
    const ism__lanes t = ism__lanes_select(
        big, ism__lanes_div(ism__lanes_sub(a, one), ism__lanes_add(a, one)), a);
    const ism__lanes z = ism__lanes_mul(t, t);
    ism__lanes angle = ism__lanes_add(ism__lanes_all(-0.1387984996f),
                                      ism__lanes_mul(z, ism__lanes_all(0.08060308882f)));
    ism__places out;
    angle = ism__lanes_add(ism__lanes_all(0.1997792608f), ism__lanes_mul(z, angle));
    angle = ism__lanes_add(ism__lanes_all(-0.3333295525f), ism__lanes_mul(z, angle));
    angle = ism__lanes_add(t, ism__lanes_mul(ism__lanes_mul(t, z), angle));
    angle = ism__lanes_select(big, ism__lanes_add(angle, ism__lanes_all(0.785398163f)), angle);
    angle = ism__lanes_select(ism__lanes_greater(zero, minor), ism__lanes_negate(angle), angle);
    out.u = ism__lanes_select(back, ism__lanes_negate(radius), radius);
    out.v = ism__lanes_mul(ism__lanes_mul(out.u, ism__lanes_all(1.27323954f)), angle);
    out.v = ism__lanes_select(back, ism__lanes_negate(out.v), out.v);
    angle = out.u;
    out.u = ism__lanes_select(wide, angle, out.v);
    out.v = ism__lanes_select(wide, out.v, angle);
    return out;
}

/* Returns by how much ism_map_coordinates stretches x and y in a map of LOBE. This takes exponentials in
   doubles, which lanes do not have. */
static inline ISM__IN_KERNEL ism__lanes ism__stretch_to_lobe(ism__lanes3 d, float exponent)
{
    float z[ISM__LANE_COUNT], sine[ISM__LANE_COUNT];
    int l;
    ism__lanes_store(z, d.z);
    ism__lanes_store(sine, ism__lanes_sqrt(ism__lanes_add(ism__lanes_mul(d.x, d.x),
                                                          ism__lanes_mul(d.y, d.y))));
    for (l = 0; l < ISM__LANE_COUNT; l++) z[l] = ism__lobe_stretch(z[l], sine[l], exponent);
    return ism__lanes_load(z);
}

/* Does for lanes what ism_map_coordinates does, for directions before the horizon. */
static inline ISM__IN_KERNEL ism__places ism__project(ism_projection projection, float exponent,
                                                      ism__lanes3 d)
{
    const ism__lanes zero = ism__lanes_all(0.0f), half = ism__lanes_all(0.5f), one = ism__lanes_all(1.0f);
    ism__lanes s;
    ism__places out;
    if (projection == ISM_PROJECTION_PARABOLOID) {
        s = ism__lanes_add(one, d.z);
        out.u = ism__lanes_div(d.x, s);
        out.v = ism__lanes_div(d.y, s);
    } else if (projection == ISM_PROJECTION_OCTAHEDRAL) {
        s = ism__lanes_add(ism__lanes_add(ism__lanes_abs(d.x), ism__lanes_abs(d.y)), d.z);
        s = ism__lanes_div(one, s);
        out.u = ism__lanes_mul(ism__lanes_add(d.x, d.y), s);
        out.v = ism__lanes_mul(ism__lanes_sub(d.x, d.y), s);
    } else {
        if (projection == ISM_PROJECTION_LOBE && exponent != 1.0f) {
            s = ism__stretch_to_lobe(d, exponent);
            d.x = ism__lanes_mul(d.x, s);
            d.y = ism__lanes_mul(d.y, s);
        }
        out = ism__square_of_disc(d.x, d.y);
    }
    out.u = ism__lanes_add(ism__lanes_mul(half, out.u), half);
    out.v = ism__lanes_add(ism__lanes_mul(half, out.v), half);
    out.u = ism__lanes_min(ism__lanes_max(out.u, zero), one);
    out.v = ism__lanes_min(ism__lanes_max(out.v, zero), one);
    return out;
}

/* ==== src/ism/kernels_splat.h ==== */

/* ---- kernels: points become discs in a tile (paper 3.3) ---- */

/* Writes the columns or rows of texels whose places in the square are within `reach` of u, as ism__to_tile
   says. */
static inline ISM__IN_KERNEL void ism__span_axis(const ism__axis *w, ism__lanes u, ism__lanes reach,
                                                 float size, int32_t *first, int32_t *last)
{
    const ism__lanes most = ism__lanes_all(size), zero = ism__lanes_all(0.0f);
    ism__lanes x0, x1;
    if (w->on) {
        const ism__lanes part = ism__lanes_div(reach, most);
        x0 = ism__lanes_mul(ism__lanes_to_tile(w, ism__lanes_sub(u, part)), most);
        x1 = ism__lanes_mul(ism__lanes_to_tile(w, ism__lanes_add(u, part)), most);
    } else {
        const ism__lanes middle = ism__lanes_mul(u, most);
        x0 = ism__lanes_sub(middle, reach);
        x1 = ism__lanes_add(middle, reach);
    }
    x1 = ism__lanes_select(ism__lanes_greater(most, x1), x1, ism__lanes_all(size - 1.0f));
    ism__ints_store(first, ism__lanes_truncate(ism__lanes_max(x0, zero)));
    ism__ints_store(last, ism__lanes_truncate(x1));
}

/* Prepares discs to be cut off at their triangles' edges. Points that stand for less than their triangle are
   cut, and may be large: so a wall has neither gaps nor discs that jut out over its end. A point that stands
   for neighbouring triangles too remains a disc. */
static inline ISM__IN_KERNEL void ism__cut_at_edges(const ism__tile *tile, ism__lane_mask cut, ism__lanes3 e1,
                                                    ism__lanes3 e2, ism__lanes3 n, ism__discs *s, size_t l)
{
    const ism__lanes zero = ism__lanes_all(0.0f);
    const ism__lanes3 none = ism__lanes3_all(0.0f, 0.0f, 0.0f);
    const ism__lanes inverse = ism__lanes_div(ism__lanes_all(1.0f), ism__lanes3_dot(n, n));
    const ism__lanes3 d1 = ism__lanes3_scale(ism__lanes3_cross(e2, n), inverse);
    const ism__lanes3 d2 = ism__lanes3_scale(ism__lanes3_cross(n, e1), inverse);
    ism__lanes_store(s->b1 + l, ism__lanes_select(cut, ism__lanes_load(s->b1 + l), zero));
    ism__lanes_store(s->b2 + l, ism__lanes_select(cut, ism__lanes_load(s->b2 + l), zero));
    ism__lanes3_store(s->d1, l, ism__lanes3_select(cut, ism__lanes3_turn(&tile->axes, d1), none));
    ism__lanes3_store(s->d2, l, ism__lanes3_select(cut, ism__lanes3_turn(&tile->axes, d2), none));
}

/* Places points in a sky's map: p from the mesh's centre, n unit. Returns which of them lie in the map. */
static inline ISM__IN_KERNEL ism__lane_mask ism__before_sky(const ism__tile *tile, ism__lanes3 p,
                                                            ism__lanes3 n, ism__discs *s, size_t l,
                                                            ism__places *uv)
{
    const ism__lanes zero = ism__lanes_all(0.0f), half = ism__lanes_all(0.5f), one = ism__lanes_all(1.0f);
    const ism__lanes r = ism__lanes_all(tile->m->radius);
    const ism__lane_mask steep = ism__lanes_greater(ism__lanes_abs(n.z), ism__lanes_all(0.05f));
    const ism__lanes slope = ism__lanes_keep(steep, ism__lanes_div(one, n.z));
    const ism__lanes depth = ism__lanes_add(p.z, r);    /* the tile's z is the way that light travels */
    ism__lanes3 g;
    ism__lane_mask inside;
    uv->u = ism__lanes_add(ism__lanes_div(ism__lanes_mul(half, p.x), r), half);
    uv->v = ism__lanes_add(ism__lanes_div(ism__lanes_mul(half, p.y), r), half);
    inside = ism__mask_and(ism__lanes_at_least(uv->u, zero), ism__lanes_at_least(uv->v, zero));
    inside = ism__mask_and(inside, ism__lanes_greater(one, uv->u));
    inside = ism__mask_and(inside, ism__lanes_greater(one, uv->v));
    g.x = ism__lanes_mul(ism__lanes_mul(ism__lanes_negate(n.x), slope), r);
    g.y = ism__lanes_mul(ism__lanes_mul(ism__lanes_negate(n.y), slope), r);
    g.z = ism__lanes_add(ism__lanes_mul(n.x, p.x), ism__lanes_mul(n.y, p.y));
    g.z = ism__lanes_add(depth, ism__lanes_mul(g.z, slope));
    p.z = depth;
    ism__lanes3_store(s->at, l, p);
    ism__lanes3_store(s->g, l, g);
    return inside;
}

/* A disc's squared radius, the disc's distance from the VPL, and whether the disc was made smaller. */
typedef struct ism__sizes { ism__lanes radius2, depth; ism__lane_mask capped; } ism__sizes;

/* Places points in a VPL's map: p from the VPL, n unit. Returns which of them the VPL sees before itself. */
static inline ISM__IN_KERNEL ism__lane_mask ism__before_vpl(const ism__tile *tile, ism__lanes3 p,
                                                            ism__lanes3 n, ism__lane_mask cut,
                                                            ism__discs *s, size_t l, ism__sizes *sizes,
                                                            ism__places *uv)
{
    const ism__lanes zero = ism__lanes_all(0.0f), one = ism__lanes_all(1.0f);
    const ism__lanes d2 = ism__lanes3_dot(p, p), along = ism__lanes3_dot(n, p), depth = ism__lanes_sqrt(d2);
    const ism__lanes least = ism__lanes_mul(ism__lanes_all(1e-3f), depth);
    const ism__lane_mask steep = ism__lanes_greater(ism__lanes_abs(along), least);
    ism__lane_mask seen = ism__mask_and(ism__lanes_greater(d2, ism__lanes_all(1e-30f)),
                                        ism__lanes_greater(p.z, least));
    ism__lanes3 g;
    ism__lanes most, away;
    if (tile->projection == ISM_PROJECTION_LOBE) {
        /* The surface that the VPL lies on is no occluder in a lobe's tilted map either. */
        const ism__orientation *f = &tile->axes;
        const float *normal = tile->vpl->normal;
        ism__lanes3 world = ism__lanes3_scale(ism__lanes3_all(f->x.x, f->x.y, f->x.z), p.x);
        world = ism__lanes3_madd(world, ism__lanes3_all(f->y.x, f->y.y, f->y.z), p.y);
        world = ism__lanes3_madd(world, ism__lanes3_all(f->z.x, f->z.y, f->z.z), p.z);
        away = ism__lanes3_dot(world, ism__lanes3_all(normal[0], normal[1], normal[2]));
        seen = ism__mask_and(seen, ism__lanes_greater(ism__lanes_abs(away), least));
    }
    /* A near disc that is seen from behind most likely juts out over the edge of something thin on the
       surface on which the VPL lies: the front of a skirting board must not hide the wall on which it hangs.
       */
    most = ism__lanes_select(ism__lanes_greater(along, zero), ism__lanes_all(ISM__WIDEST_BACK),
                             ism__lanes_all(ISM__WIDEST));
    most = ism__lanes_mul(ism__lanes_select(cut, ism__lanes_all(ISM__WIDEST), most), d2);
    sizes->capped = ism__lanes_greater(sizes->radius2, most);
    sizes->radius2 = ism__lanes_select(sizes->capped, most, sizes->radius2);
    *uv = ism__project(tile->projection, tile->vpl->exponent,
                       ism__lanes3_scale(p, ism__lanes_div(one, depth)));
    /* A disc that is seen from its edge has a plane that faces the VPL instead. */
    g = ism__lanes3_select(steep, ism__lanes3_scale(n, ism__lanes_div(one, along)),
                           ism__lanes3_scale(p, ism__lanes_div(one, d2)));
    /* A disc that stands for its triangle's neighbours too is about as far off their surface as it is wide,
       and would hide that surface from the VPL: it is drawn a radius farther away, as large as before for the
       VPL. */
    away = ism__lanes_add(one, ism__lanes_div(ism__lanes_sqrt(sizes->radius2), depth));
    away = ism__lanes_select(cut, one, away);
    ism__lanes3_store(s->at, l, ism__lanes3_scale(p, away));
    ism__lanes3_store(s->g, l, ism__lanes3_scale(g, ism__lanes_div(one, away)));
    sizes->radius2 = ism__lanes_mul(sizes->radius2, ism__lanes_mul(away, away));
    sizes->depth = ism__lanes_mul(depth, away);
    return seen;
}

/* Does what ism__splat's `place` does, for as many points as there are lanes, from point l on. */
static inline ISM__IN_KERNEL uint32_t ism__place_some(ism__tile *tile, ism__discs *s, size_t l)
{
    const int sky = tile->vpl->directional != 0;
    const float *from = sky ? tile->m->center : tile->vpl->position, scale = tile->m->desc.splat_scale;
    const ism__lanes one = ism__lanes_all(1.0f), zero = ism__lanes_all(0.0f);
    const ism__lanes weight = ism__lanes_load(s->weight + l);
    const ism__lane_mask cut = ism__lanes_greater(one, weight);
    ism__lanes3 p = ism__lanes3_load(s->corners[0][0] + l, s->corners[0][1] + l, s->corners[0][2] + l);
    const ism__lanes3 e1 = ism__lanes3_sub(ism__lanes3_load(s->corners[1][0] + l, s->corners[1][1] + l,
                                                            s->corners[1][2] + l), p);
    const ism__lanes3 e2 = ism__lanes3_sub(ism__lanes3_load(s->corners[2][0] + l, s->corners[2][1] + l,
                                                            s->corners[2][2] + l), p);
    const ism__lanes3 n = ism__lanes3_cross(e1, e2);
    const ism__lanes length = ism__lanes_sqrt(ism__lanes3_dot(n, n));
    ism__lanes area = ism__lanes_mul(ism__lanes_mul(ism__lanes_all(scale), weight), ism__lanes_all(0.5f));
    ism__lanes reach;
    ism__lane_mask seen = ism__mask_and(ism__lanes_greater(length, zero),
                                        ism__lanes_at_least(ism__lanes_all(ISM__MAX_FLOAT), length));
    ism__lanes3 normal = ism__lanes3_scale(n, ism__lanes_div(one, length));
    ism__sizes sizes;
    ism__places uv;
    p = ism__lanes3_madd(ism__lanes3_madd(p, e1, ism__lanes_load(s->b1 + l)), e2,
                         ism__lanes_load(s->b2 + l));
    p = ism__lanes3_turn(&tile->axes, ism__lanes3_sub(p, ism__lanes3_all(from[0], from[1], from[2])));
    normal = ism__lanes3_turn(&tile->axes, normal);
    area = ism__lanes_mul(area, length);
    area = ism__lanes_select(cut, ism__lanes_mul(area, ism__lanes_all(ISM__CUT_SCALE)), area);
    ism__cut_at_edges(tile, cut, e1, e2, n, s, l);
    sizes.radius2 = ism__lanes_mul(area, ism__lanes_all(1.0f / ISM__PI));
    sizes.depth = one;
    sizes.capped = ism__lanes_greater(zero, one);
    if (sky) seen = ism__mask_and(seen, ism__before_sky(tile, p, normal, s, l, &uv));
    else seen = ism__mask_and(seen, ism__before_vpl(tile, p, normal, cut, s, l, &sizes, &uv));
    ism__lanes_store(s->radius2 + l, sizes.radius2);
    seen = ism__mask_and(seen, ism__mask_of_bits(s->count - (uint32_t)l < ISM__LANE_COUNT
                                               ? (1u << (s->count - (uint32_t)l)) - 1u
                                               : UINT32_MAX));
    tile->splats += ism__mask_count(seen);
    reach = ism__lanes_mul(ism__lanes_sqrt(sizes.radius2), ism__lanes_all(tile->texels_per_unit));
    reach = ism__lanes_div(reach, sizes.depth);
    seen = ism__mask_and(seen, ism__lanes_greater(reach, zero));
    tile->wide += ism__mask_count(ism__mask_and(seen, sizes.capped));
    /* The map is continuous but across its diagonals near the border, where a disc is cut off. */
    reach = ism__lanes_keep(seen, ism__lanes_min(reach, ism__lanes_all((float)tile->size)));
    uv.u = ism__lanes_keep(seen, uv.u);
    uv.v = ism__lanes_keep(seen, uv.v);
    ism__span_axis(&tile->window->u, uv.u, reach, (float)tile->size, s->box[0] + l, s->box[1] + l);
    ism__span_axis(&tile->window->v, uv.v, reach, (float)tile->size, s->box[2] + l, s->box[3] + l);
    return ism__mask_bits(seen);
}

/* This is `place` of ism__splat. */
ISM__KERNEL static uint32_t ism__place_discs(ism__tile *tile, ism__discs *s)
{
    uint32_t bits = 0;
    size_t l;
    for (l = 0; l < s->count; l += ISM__LANE_COUNT) bits |= ism__place_some(tile, s, l) << l;
    return bits;
}

#if ISM__LANE_COUNT == 8
/* Returns a bit for each of eight texels, from texel i on, whose rays meet the disc, and nothing nearer; and
   writes the depths at which they meet its plane. */
static inline ISM__IN_KERNEL uint32_t ism__texels_hit(const ism__tile *tile, const ism__discs *s, size_t d,
                                                      size_t i, int sky, float depths[8])
{
    const ism__lanes zero = ism__lanes_all(0.0f), edge = ism__lanes_all(-ISM__EDGE);
    const ism__lanes3 w = ism__lanes3_load(tile->x + i, tile->y + i, tile->z + i);
    const ism__lanes plane = ism__lanes3_dot(ism__lanes3_all(s->g[0][d], s->g[1][d], s->g[2][d]), w);
    const ism__lanes depth = sky ? plane : ism__lanes_div(ism__lanes_all(1.0f), plane);
    const ism__lanes wide = sky ? ism__lanes_all(tile->m->radius) : depth;
    ism__lane_mask hit = ism__lanes_greater(plane, sky ? zero : ism__lanes_all(1e-20f));
    ism__lanes b1, b2;
    ism__lanes3 o;
    o.x = ism__lanes_sub(ism__lanes_mul(w.x, wide), ism__lanes_all(s->at[0][d]));
    o.y = ism__lanes_sub(ism__lanes_mul(w.y, wide), ism__lanes_all(s->at[1][d]));
    o.z = ism__lanes_sub(sky ? depth : ism__lanes_mul(w.z, depth), ism__lanes_all(s->at[2][d]));
    b1 = ism__lanes3_dot(o, ism__lanes3_all(s->d1[0][d], s->d1[1][d], s->d1[2][d]));
    b2 = ism__lanes3_dot(o, ism__lanes3_all(s->d2[0][d], s->d2[1][d], s->d2[2][d]));
    b1 = ism__lanes_add(ism__lanes_all(s->b1[d]), b1);
    b2 = ism__lanes_add(ism__lanes_all(s->b2[d]), b2);
    hit = ism__mask_and(hit, ism__lanes_greater(depth, zero));
    hit = ism__mask_and(hit, ism__lanes_greater(ism__lanes_load(tile->depth + i), depth));
    hit = ism__mask_and(hit, ism__lanes_at_least(ism__lanes_all(s->radius2[d]), ism__lanes3_dot(o, o)));
    hit = ism__mask_and(hit, ism__mask_and(ism__lanes_at_least(b1, edge), ism__lanes_at_least(b2, edge)));
    hit = ism__mask_and(hit, ism__lanes_at_least(ism__lanes_all(1.0f + ISM__EDGE), ism__lanes_add(b1, b2)));
    ism__lanes_store(depths, depth);
    return ism__mask_bits(hit);
}

/* Draws disc d into the texels of its box. No disc is widened to a whole texel: where many small ones share
   it, the chance that one holds the centre is the share of the texel that they cover, so that over many VPLs
   thin things throw thin shadows. Eight texels at a time; a row's last eight may begin before the box. */
static inline ISM__IN_KERNEL void ism__draw_disc(ism__tile *tile, const ism__discs *s, size_t d, int sky)
{
    const int32_t size = (int32_t)tile->size, last = s->box[1][d];
    int32_t x, y;
    for (y = s->box[2][d]; y <= s->box[3][d]; y++)
        for (x = s->box[0][d]; x <= last; x += 8) {
            const int32_t column = x < size - 8 ? x : size - 8, end = last - column;
            const size_t i = (size_t)(y * size + column);
            float depths[8];
            uint32_t bits = ism__texels_hit(tile, s, d, i, sky, depths);
            bits &= (255u << (x - column)) & (end < 8 ? (2u << end) - 1u : 255u);
            for (; bits; bits &= bits - 1u) {
                const size_t k = ism__first_bit(bits);
                ism__texel *to = &tile->texels[i + k];
                to->g[0] = s->g[0][d];
                to->g[1] = s->g[1][d];
                to->g[2] = s->g[2][d];
                to->triangle = s->triangle[d];
                tile->depth[i + k] = depths[k];
            }
        }
}

/* This is `draw` of ism__splat. */
ISM__KERNEL static void ism__draw_discs(ism__tile *tile, const ism__discs *s, uint32_t bits)
{
    if (tile->vpl->directional)
        for (; bits; bits &= bits - 1u) ism__draw_disc(tile, s, ism__first_bit(bits), 1);
    else
        for (; bits; bits &= bits - 1u) ism__draw_disc(tile, s, ism__first_bit(bits), 0);
}
#endif

/* ==== src/ism/kernels_spread.h ==== */

/* ---- kernels: what receivers see of a triangle (paper 5.1, 5.2) ---- */

#if ISM__LANE_COUNT == 8
/* See ism__triangle_kernel. The solid angle of a triangle that is small for its distance is taken for area
   cos / d^2, whose relative error is at most area / d^2. */
ISM__KERNEL static float ism__mean_solid_angle(const ism__v3 p[3], ism__v3 normal2,
                                               const float views[3][ISM__VIEWS], uint32_t count)
{
    const ism__lanes area2 = ism__lanes_all(ism__v3_length(normal2));
    const ism__lanes3 n = ism__lanes3_all(normal2.x, normal2.y, normal2.z);
    const ism__lanes3 a = ism__lanes3_sub(ism__lanes3_all(p[0].x, p[0].y, p[0].z),
                                          ism__lanes3_load(views[0], views[1], views[2]));
    const ism__lanes d2 = ism__lanes3_dot(a, a);
    const ism__lane_mask distant = ism__lanes_greater(ism__lanes_mul(ism__lanes_all(0.01f), d2), area2);
    const ism__lanes solid = ism__lanes_div(
        ism__lanes_mul(ism__lanes_all(0.5f), ism__lanes_abs(ism__lanes3_dot(n, a))),
        ism__lanes_mul(d2, ism__lanes_sqrt(d2)));
    const uint32_t far_bits = ism__mask_bits(distant);
    float solids[ISM__VIEWS], sum = 0.0f;
    uint32_t k, i;
    ism__lanes_store(solids, solid);
    for (k = 0; k < count; k++) {
        float corners[9];
        for (i = 0; i < 3u && !(far_bits >> k & 1u); i++) {
            corners[3u * i] = p[i].x - views[0][k];
            corners[3u * i + 1u] = p[i].y - views[1][k];
            corners[3u * i + 2u] = p[i].z - views[2][k];
        }
        sum += far_bits >> k & 1u ? solids[k] : ism__solid_angle(corners, corners + 3, corners + 6);
    }
    return sum / (float)count;
}
#endif

/* ==== src/ism/kernels_pair.h ==== */

/* ---- kernels: which share of a VPL's map clusters of triangles fill ---- */

#define ism__lanes_facing ISM__NAME_IN_SET(ism__lanes_facing, ISM__SET)
#define ism__cluster_effect ISM__NAME_IN_SET(ism__cluster_effect, ISM__SET)
#define ism__box_zoom ISM__NAME_IN_SET(ism__box_zoom, ISM__SET)
#define ism__cluster_zoom ISM__NAME_IN_SET(ism__cluster_zoom, ISM__SET)
#define ism__weigh_clusters ISM__NAME_IN_SET(ism__weigh_clusters, ISM__SET)

/* Returns the mean square of n . l over the normals n of clusters, or 0 where rounding made it negative. */
static inline ISM__IN_KERNEL ism__lanes ism__lanes_facing(const ism__clusters *c, size_t i, ism__lanes3 l)
{
    const ism__lanes xx = ism__lanes_mul(ism__lanes_mul(ism__lanes_load(c->n[0] + i), l.x), l.x);
    const ism__lanes yy = ism__lanes_mul(ism__lanes_mul(ism__lanes_load(c->n[1] + i), l.y), l.y);
    const ism__lanes zz = ism__lanes_mul(ism__lanes_mul(ism__lanes_load(c->n[2] + i), l.z), l.z);
    const ism__lanes yz = ism__lanes_mul(ism__lanes_mul(ism__lanes_load(c->n[3] + i), l.y), l.z);
    const ism__lanes zx = ism__lanes_mul(ism__lanes_mul(ism__lanes_load(c->n[4] + i), l.z), l.x);
    const ism__lanes xy = ism__lanes_mul(ism__lanes_mul(ism__lanes_load(c->n[5] + i), l.x), l.y);
    const ism__lanes mixed = ism__lanes_mul(ism__lanes_all(2.0f), ism__lanes_add(ism__lanes_add(yz, zx), xy));
    const ism__lanes sum = ism__lanes_add(ism__lanes_add(ism__lanes_add(xx, yy), zz), mixed);
    return ism__lanes_max(sum, ism__lanes_all(0.0f));
}

/* Returns about which share of the VPL's map clusters fill: their cosine-weighted solid angles; in a map of
   directions their projected areas. */
static inline ISM__IN_KERNEL ism__lanes ism__cluster_effect(const ism__clusters *c, size_t i,
                                                            const ism_vpl *v)
{
    const ism__lanes zero = ism__lanes_all(0.0f), one = ism__lanes_all(1.0f);
    const ism__lanes area = ism__lanes_load(c->area + i), radius2 = ism__lanes_load(c->radius2 + i);
    const ism__lanes wide = ism__lanes_mul(ism__lanes_all(0.16f), area);
    const ism__lanes3 n = ism__lanes3_all(v->normal[0], v->normal[1], v->normal[2]);
    ism__lanes3 l = n;
    ism__lanes away2, d2;
    ism__lanes along, facing2, effect;
    if (v->directional) {
        facing2 = ism__lanes_facing(c, i, l);
        effect = ism__lanes_mul(area, ism__lanes_sqrt(facing2));
        return ism__lanes_keep(ism__lanes_greater(area, zero), effect);
    }
    l = ism__lanes3_sub(ism__lanes3_load(c->at[0] + i, c->at[1] + i, c->at[2] + i),
                        ism__lanes3_all(v->position[0], v->position[1], v->position[2]));
    away2 = ism__lanes3_dot(l, l);
    d2 = ism__lanes_add(ism__lanes_add(away2, radius2), wide);
    along = ism__lanes_add(ism__lanes3_dot(l, n), ism__lanes_sqrt(radius2));
    facing2 = ism__lanes_add(ism__lanes_facing(c, i, l),        /* close clusters are seen from all sides */
                             ism__lanes_add(radius2, wide));
    effect = ism__lanes_mul(ism__lanes_mul(area, ism__lanes_sqrt(facing2)),
                            ism__lanes_div(along, ism__lanes_mul(d2, d2)));
    effect = ism__lanes_keep(ism__lanes_greater(along, zero), effect);
    effect = ism__lanes_select(ism__lanes_greater(away2, zero), effect, one);
    return ism__lanes_keep(ism__lanes_greater(area, zero), effect);
}

/* Returns how many times longer the range within r of u is in the tile than in the square. */
static inline ISM__IN_KERNEL ism__lanes ism__box_zoom(const ism__axis *w, ism__lanes u, ism__lanes r)
{
    const ism__lanes one = ism__lanes_all(1.0f), zero = ism__lanes_all(0.0f);
    const ism__lanes low = ism__lanes_select(ism__lanes_greater(u, r), ism__lanes_sub(u, r), zero);
    const ism__lanes high = ism__lanes_min(ism__lanes_add(u, r), one);
    const ism__lanes from = w->on ? ism__lanes_to_tile(w, low) : low;
    const ism__lanes to = w->on ? ism__lanes_to_tile(w, high) : high;
    return ism__lanes_div(ism__lanes_sub(to, from), ism__lanes_sub(high, low));
}

/* Returns about how many times more texels clusters have than in a map that shows the square evenly: the mean
   over a box of their size. Clusters behind the horizon, which may have a part before the horizon, count as
   on the horizon. */
static inline ISM__IN_KERNEL ism__lanes ism__cluster_zoom(const ism_maps *m, const ism__clusters *c,
                                                          size_t i, const ism_vpl *v,
                                                          const ism__orientation *f, const ism__window *w)
{
    const float *origin = v->directional ? m->center : v->position;
    const ism__lanes zero = ism__lanes_all(0.0f), half = ism__lanes_all(0.5f), one = ism__lanes_all(1.0f);
    const ism__lanes3 from = ism__lanes3_all(origin[0], origin[1], origin[2]);
    const ism__lanes3 z = ism__lanes3_all(f->z.x, f->z.y, f->z.z);
    ism__lanes3 at = ism__lanes3_sub(ism__lanes3_load(c->at[0] + i, c->at[1] + i, c->at[2] + i), from);
    ism__lanes d = ism__lanes_all(m->radius), r = ism__lanes_sqrt(ism__lanes_load(c->radius2 + i)), zoom;
    ism__lane_mask seen;
    ism__places uv;
    if (!v->directional) {
        const ism__lanes below = ism__lanes3_dot(z, at);
        ism__lanes least;
        d = ism__lanes_sqrt(ism__lanes3_dot(at, at));
        least = ism__lanes_mul(ism__lanes_all(0.05f), d);
        at = ism__lanes3_select(ism__lanes_greater(least, below),
                                ism__lanes3_madd(at, z, ism__lanes_sub(least, below)), at);
    }
    at.x = ism__lanes_sub(ism__lanes_add(from.x, at.x), from.x);
    at.y = ism__lanes_sub(ism__lanes_add(from.y, at.y), from.y);
    at.z = ism__lanes_sub(ism__lanes_add(from.z, at.z), from.z);
    at = ism__lanes3_turn(f, at);
    if (v->directional) {
        uv.u = ism__lanes_add(ism__lanes_div(ism__lanes_mul(half, at.x), d), half);
        uv.v = ism__lanes_add(ism__lanes_div(ism__lanes_mul(half, at.y), d), half);
        seen = ism__mask_and(ism__lanes_at_least(uv.u, zero), ism__lanes_at_least(uv.v, zero));
        seen = ism__mask_and(seen, ism__lanes_greater(one, uv.u));
        seen = ism__mask_and(seen, ism__lanes_greater(one, uv.v));
    } else {
        const ism__lanes length = ism__lanes_sqrt(ism__lanes3_dot(at, at));
        at = ism__lanes3_scale(at, ism__lanes_div(one, length));
        seen = ism__mask_and(ism__lanes_greater(length, zero),
                             ism__lanes_at_least(ism__lanes_all(ISM__MAX_FLOAT), length));
        seen = ism__mask_and(seen, ism__lanes_greater(at.z, zero));
        uv = ism__project(ism__projection_of(m, v), v->exponent, at);
    }
    r = ism__lanes_div(ism__lanes_mul(half, r), d);     /* a radian is about half the square */
    r = ism__lanes_max(r, ism__lanes_all(0.01f));
    zoom = ism__lanes_mul(ism__box_zoom(&w->u, uv.u, r), ism__box_zoom(&w->v, uv.v, r));
    return ism__lanes_select(seen, zoom, one);
}

/* See ism__cluster_kernel. */
ISM__KERNEL static void ism__weigh_clusters(const ism__spread_work *w, const ism_vpl *v, float *effect)
{
    const ism_maps *m = w->m;
    const ism__window *window = (const ism__window *)m->windows.data + (v - m->vpls);
    const ism__orientation f = ism__vpl_axes(m, v);
    const int windows = window->u.on || window->v.on;
    size_t c;
    for (c = 0; c < w->cluster_count; c += ISM__LANE_COUNT) {
        const ism__clusters *from = &w->clusters[c / ISM__BUNDLE];
        const size_t i = c % ISM__BUNDLE, count = w->cluster_count - c;
        ism__lanes some = ism__cluster_effect(from, i, v);
        float last[ISM__LANE_COUNT];
        if (windows) some = ism__lanes_select(ism__lanes_greater(some, ism__lanes_all(0.0f)),
                                              ism__lanes_mul(some, ism__cluster_zoom(m, from, i, v, &f,
                                                                                     window)), some);
        some = ism__lanes_keep(ism__lanes_at_least(ism__lanes_all(ISM__MAX_FLOAT), some), some);
        if (count >= ISM__LANE_COUNT) {
            ism__lanes_store(effect + c, some);
            continue;
        }
        ism__lanes_store(last, some);
        memcpy(effect + c, last, count * sizeof *last);
    }
}

/* ==== src/ism/kernels_end.h ==== */

#undef ISM__SET
#undef ISM__WIDTH
#undef ISM__LANE_COUNT
#endif /* ISM__SET */

#if defined(ISM_IMPLEMENTATION) && !defined(ISM_IMPLEMENTED)
#define ISM_IMPLEMENTED

/* ---- kernels: those of other instruction sets, and which to call ---- */

#if ISM__SIMD_SETS
#define ISM__SET avx2
#define ISM__WIDTH 8
#define ISM__LANE_COUNT 8
#include ISM__FILE
#define ISM__SET avx512
#define ISM__WIDTH 16
#define ISM__LANE_COUNT 16
#include ISM__FILE
#endif

static ism__splat ism__choose_splat(void)
{
    ism__splat kernels = { ism__place_discs_plain, ism__draw_discs_plain };
#if ISM__SIMD_SETS
    const int level = ism__simd_level();
    if (level) {
        kernels.place = level == 2 ? ism__place_discs_avx512 : ism__place_discs_avx2;
        kernels.draw = ism__draw_discs_avx2;
    }
#endif
    return kernels;
}

static void ism__choose_spread(ism__spread_work *w)
{
#if ISM__SIMD_SETS
    const int level = ism__simd_level();
#endif
    w->mean_solid_angle = ism__mean_solid_angle_plain;
#if ISM__SIMD_SETS
    if (level) w->mean_solid_angle = ism__mean_solid_angle_avx2;
#endif
#ifndef ISM_WITHOUT_PAIR
    w->weigh_clusters = ism__weigh_clusters_plain;
#if ISM__SIMD_SETS
    if (level) w->weigh_clusters = level == 2 ? ism__weigh_clusters_avx512 : ism__weigh_clusters_avx2;
#endif
#endif
}

/* ==== src/ism/clusters.h ==== */

/* ---- clusters: triangles are put together, for what a VPL sees of them ---- */

/* Measures cluster c, which is triangles t to end - 1. A cluster without area is all 0, since kernels compute
   on its lane too. */
static void ism__measure_cluster(const ism__spread_work *w, size_t c, size_t t, size_t end)
{
    ism__v3 p[3], from;
    double at[3] = { 0.0, 0.0, 0.0 }, square = 0.0, sum = 0.0, nn[6] = { 0.0, 0.0, 0.0, 0.0, 0.0, 0.0 };
    ism__clusters *out = &w->clusters[c / ISM__BUNDLE];
    size_t lane = c % ISM__BUNDLE;
    int k;
    out->area[lane] = out->radius2[lane] = 0.0f;
    for (k = 0; k < 3; k++) out->at[k][lane] = 0.0f;
    for (k = 0; k < 6; k++) out->n[k][lane] = 0.0f;
    for (from = ism__v3_make(0.0f, 0.0f, 0.0f); t < end; t++) {
        ism__v3 g, n;
        float area = w->area[t];
        if (!(area > 0.0f)) continue;
        ism__corners(w->mesh, t, p);
        n = ism__v3_scale(ism__v3_cross(ism__v3_sub(p[1], p[0]), ism__v3_sub(p[2], p[0])), 0.5f / area);
        if (!(sum > 0.0)) from = p[0];      /* places are relative to this one, so that sums of squares
                                               keep their digits far from the origin */
        for (k = 0; k < 3; k++) p[k] = ism__v3_sub(p[k], from);
        g = ism__v3_scale(ism__v3_add(ism__v3_add(p[0], p[1]), p[2]), 1.0f / 3.0f);
        sum += (double)area;
        at[0] += (double)(area * g.x);
        at[1] += (double)(area * g.y);
        at[2] += (double)(area * g.z);
        square += (double)(area * (9.0f * ism__v3_dot(g, g) + ism__v3_dot(p[0], p[0]) +
                                   ism__v3_dot(p[1], p[1]) + ism__v3_dot(p[2], p[2]))) /
                  12.0;
        nn[0] += (double)(area * n.x * n.x);
        nn[1] += (double)(area * n.y * n.y);
        nn[2] += (double)(area * n.z * n.z);
        nn[3] += (double)(area * n.y * n.z);
        nn[4] += (double)(area * n.z * n.x);
        nn[5] += (double)(area * n.x * n.y);
    }
    if (!(sum > 0.0)) return;
    for (k = 0; k < 6; k++) out->n[k][lane] = (float)(nn[k] / sum);
    for (k = 0; k < 3; k++) at[k] /= sum;
    square = square / sum - at[0] * at[0] - at[1] * at[1] - at[2] * at[2];
    out->at[0][lane] = from.x + (float)at[0];
    out->at[1][lane] = from.y + (float)at[1];
    out->at[2][lane] = from.z + (float)at[2];
    out->radius2[lane] = square > 0.0 ? (float)square : 0.0f;
    out->area[lane] = (float)sum;
}

/* ==== src/ism/triangles.h ==== */

/* ---- triangles: which of them get points, by the view (paper 5.1, 5.2) and by each VPL ---- */

/* Returns a triangle's mean solid angle as seen from its receivers. */
static float ism__seen_by_view(const ism__spread_work *w, size_t t, const ism__v3 p[3], ism__v3 normal2)
{
    const ism_points *points = w->view->points;
    uint32_t count = w->m->desc.spread == ISM_SPREAD_VIEW_1 ? 1u : (uint32_t)ISM__VIEWS, k;
    uint32_t key = ism__hash_combine(w->m->desc.seed, 0x7000u + (count == 1u ? 0u : (uint32_t)t));
    float views[3][ISM__VIEWS] = { { 0.0f } };
    for (k = 0; k < count; k++) {
        uint32_t i = (uint32_t)((uint64_t)ism__hash_combine(key, k) * w->valid_count >> 32);
        const float *v = ism__at(points->positions, points->position_stride, w->valid[i]);
        views[0][k] = v[0];
        views[1][k] = v[1];
        views[2][k] = v[2];
    }
    return w->mean_solid_angle(p, normal2, (const float (*)[ISM__VIEWS])views, count);
}

static void ism__spread_task(void *context, size_t index)
{
    ism__spread_work *w = (ism__spread_work *)context;
    size_t t = index * ISM__TRIANGLES,
           end = t + ISM__TRIANGLES < w->triangles ? t + ISM__TRIANGLES : w->triangles;
    int adaptive = w->m->desc.spread != ISM_SPREAD_AREA && w->valid_count > 0;
    for (; t < end; t++) {
        ism__v3 p[3], n;
        float area, solid = 0.0f;
        if (ism__index(w->mesh, 3u * t) >= w->mesh->vertex_count ||
            ism__index(w->mesh, 3u * t + 1u) >= w->mesh->vertex_count ||
            ism__index(w->mesh, 3u * t + 2u) >= w->mesh->vertex_count) {
            w->area[t] = -1.0f;     /* an error, found by the thread that called us */
            continue;
        }
        ism__corners(w->mesh, t, p);
        n = ism__v3_cross(ism__v3_sub(p[1], p[0]), ism__v3_sub(p[2], p[0]));
        area = 0.5f * ism__v3_length(n);
        if (!(area > 0.0f) || !ism__finite(area)) area = 0.0f;
        else if (adaptive) solid = ism__seen_by_view(w, t, p, n);
        w->area[t] = area;
        w->solid[t] = ism__finite(solid) ? solid : 0.0f;
    }
}

/* Lists the pixels that are no background. */
static ism_result ism__valid_pixels(ism_maps *m, const ism__view *view, uint32_t *count)
{
    size_t pixels = (size_t)view->width * view->height, i;
    uint32_t *valid;
    ism__v3 p, n;
    if (!ism__grow(m, &m->pixels, pixels, sizeof *valid)) return ISM_ERR_ALLOC;
    valid = (uint32_t *)m->pixels.data;
    for (*count = 0, i = 0; i < pixels; i++)
        if (ism__receiver(view, i, &p, &n)) valid[(*count)++] = (uint32_t)i;
    return ISM_OK;
}

/* Makes the prefix sums from which triangles are drawn: of solid angles, and of a share of areas, so that
   triangles that are seen from their edge are drawn too. */
static void ism__make_cdf(ism__spread_work *w, double area_sum, double solid_sum)
{
    ism_maps *m = w->m;
    double a = solid_sum > 0.0 ? (double)m->desc.area_share / area_sum : 1.0 / area_sum;
    double s = solid_sum > 0.0 ? (1.0 - (double)m->desc.area_share) / solid_sum : 0.0,
           *sums = (double *)m->sums.data;
    double sum = 0.0;
    size_t t;
    for (t = 0; t < w->triangles; t++) {
        sums[t] = sum;
        if (w->area[t] > 0.0f) sum += a * (double)w->area[t] + s * (double)w->solid[t];
    }
    sums[w->triangles] = sum;
    w->cdf.sums = sums;
    w->cdf.count = (uint32_t)w->triangles;
}

/* Finds which share of the points a cluster gets by what the view sees, and measures the cluster for VPLs. */
static void ism__cluster_task(void *context, size_t c)
{
    const ism__spread_work *w = (const ism__spread_work *)context;
    size_t t = c * w->cluster_size;
    size_t end = t + w->cluster_size < w->triangles ? t + w->cluster_size : w->triangles;
    w->seen[c] = (w->cdf.sums[end] - w->cdf.sums[t]) / ism__cdf_total(&w->cdf);
#ifndef ISM_WITHOUT_PAIR
    ism__measure_cluster(w, c, t, end);
#endif
}

/* Writes prefix sums of the clusters' shares of a VPL's points. A share is the geometric mean of what the
   view and the VPL see of the cluster, and a little of either alone, so that no cluster is forgotten. v: NULL
   = only the view counts. */
static void ism__share_clusters(const ism__spread_work *w, const ism_vpl *v, float *effect, double *sums)
{
    double seen = 0.0, sum = 0.0;
    uint32_t c;
#ifndef ISM_WITHOUT_PAIR
    if (v) w->weigh_clusters(w, v, effect);
#endif
    for (c = 0; v && c < w->cluster_count; c++) seen += (double)effect[c];
    for (c = 0; c < w->cluster_count; c++) {
        double p = w->seen[c];
        double q = seen > 0.0 ? (double)effect[c] / seen : p;
        sums[c] = sum;
        if (p > 0.0) sum += sqrt(p * q) + ISM__EITHER * (p + q);
    }
    sums[c] = sum;
}

/* ==== src/ism/points.h ==== */

/* ---- points: surfels on all triangles (paper 5) ---- */

/* Writes barycentric coordinates of a place (u, v) in the square; an even density stays even. After Heitz, "A
   low-distortion map between triangle and square", 2019: nothing is folded, so that points of low discrepancy
   stay such. */
static void ism__triangle_map(float u, float v, float *b1, float *b2)
{
    if (v > u) {
        u *= 0.5f;
        v -= u;
    } else {
        v *= 0.5f;
        u -= v;
    }
    *b1 = u;
    *b2 = v;
}

/* Returns the cell i among first <= i < end with sums[i] <= x < sums[i + 1], never one without width. The
   search begins at `from`, if that is not behind x, by steps that double, since successive points lie in
   successive cells. */
static size_t ism__find(const double *sums, size_t first, size_t end, size_t from, double x)
{
    size_t lo = first, hi = end, step = 1;
    if (from > first && sums[from] <= x) {
        for (lo = from; end - lo > step && sums[lo + step] <= x; step *= 2u) lo += step;
        if (end - lo > step) hi = lo + step;
    }
    while (hi - lo > 1u) {
        size_t middle = lo + (hi - lo) / 2u;
        if (sums[middle] <= x) lo = middle;
        else hi = middle;
    }
    while (lo > first && !(sums[lo + 1u] > sums[lo])) lo--;
    while (lo + 1u < end && !(sums[lo + 1u] > sums[lo])) lo++;
    return lo;
}

/* Draws a triangle of cluster c, by the place of x within the cluster's share. Returns the probability with
   which this triangle is drawn among all. */
static double ism__choose_triangle(const ism__spread_work *w, const double *shares, size_t c, double x,
                                 uint32_t *triangle)
{
    const double *sums = w->cdf.sums;
    size_t first = c * w->cluster_size, end = first + w->cluster_size, t;
    double share = shares[c + 1u] - shares[c], width;
    if (end > w->triangles) end = w->triangles;
    width = sums[end] - sums[first];
    t = ism__find(sums, first, end, first, sums[first] + (x - shares[c]) / share * width);
    *triangle = (uint32_t)t;
    return share / shares[w->cluster_count] * ((sums[t + 1u] - sums[t]) / width);
}

/* Returns whether a point of a mesh lies in a hole of its mask. */
static int ism__is_hole(const ism_mesh *mesh, const ism__surfel *p)
{
    float weights[3];
    if (!mesh->mask_fn) return 0;
    weights[1] = (float)p->b1 * (1.0f / 65535.0f);
    weights[2] = (float)p->b2 * (1.0f / 65535.0f);
    weights[0] = 1.0f - weights[1] - weights[2];
    return !mesh->mask_fn(mesh->user, p->triangle, weights);
}

/* Makes point `at` of n anew, on a triangle of cluster c, by where x lies in its share. Points in holes of a
   mask stand for no area, the others for as much as without a mask: together for what is there. */
static void ism__make_point(const ism__spread_work *w, const double *shares, size_t c, double x, uint32_t key,
                            uint32_t at, uint32_t n, ism__surfel *to)
{
    uint32_t r = key + at * 3242174889u, s = ism__hash32(key) + at * 2447445413u;
    double probability = ism__choose_triangle(w, shares, c, x, &to->triangle);
    float b1, b2;
    ism__triangle_map(ism__to_unit(r), ism__to_unit(s), &b1, &b2);
    to->b1 = (uint16_t)(b1 * 65535.0f);
    to->b2 = (uint16_t)(b2 * 65535.0f);
    to->weight = probability > 0.0 ? (float)(1.0 / ((double)n * probability)) : 0.0f;
    if (ism__is_hole(w->mesh, to)) to->weight = 0.0f;
}

/* Makes the points of a VPL's tile. Each VPL has stratified random numbers (j + r) / n of its own, the same
   in every frame, so that a static scene stays as it is; one in lazy_frames of the points is made anew. So
   are points whose triangles are gone, from all triangles, since they were neighbours in the strata. Clusters
   are found for several points at once; sums of triangles are fetched meanwhile: no cache holds them all. */
static void ism__points_of(const ism__spread_work *w, size_t v, const double *shares)
{
    ism_maps *m = w->m;
    uint32_t *counts = (uint32_t *)m->counts.data + 2u * v;
    ism__surfel *points = (ism__surfel *)m->surfels.data + v * m->desc.surfel_count;
    const uint32_t n = counts[0], phase = w->frame % w->period;
    const int fresh = w->fresh || n != counts[1];
    const uint32_t step = fresh || w->fewer ? 1u : w->period;
    const uint32_t seed = m->desc.unstable ? ism__hash_combine(m->desc.seed, w->frame) : m->desc.seed;
    const uint32_t key = ism__hash_combine(seed, 0x9000u + (uint32_t)v);
    const uint32_t again = ism__hash_combine(key, w->frame);
    uint32_t numbers[ISM__AHEAD], clusters[ISM__AHEAD];
    uint32_t j, k, used;
    double x[ISM__AHEAD];
    size_t c = 0, i;
    counts[1] = 0;
    for (j = step > 1u ? phase : 0; j < n;) {
        for (used = 0; used < ISM__AHEAD && j < n; j += step) {
            const int due = fresh || j % w->period == phase;
            const double unit = (double)ism__to_unit(ism__hash_combine(due ? key : again, j));
            if (!due && points[j].triangle < w->triangles) continue;
            x[used] = (due ? ((double)j + unit) / (double)n : unit) * shares[w->cluster_count];
            c = ism__find(shares, 0, w->cluster_count, c, x[used]);
            for (i = c * w->cluster_size; i <= w->triangles && i <= (c + 1u) * w->cluster_size; i += 8u)
                ISM__PREFETCH(w->cdf.sums + i);
            clusters[used] = (uint32_t)c;
            numbers[used++] = j;
        }
        for (k = 0; k < used; k++)
            ism__make_point(w, shares, clusters[k], x[k], key, numbers[k], n, &points[numbers[k]]);
        counts[1] += used;
    }
}

/* Returns how many doubles a lane needs: prefix sums of shares, and as many floats for clusters' effects. */
static size_t ism__lane_shares(const ism__spread_work *w)
{
    return (size_t)w->cluster_count + w->cluster_count / 2u + 2u;
}

/* Makes the points of every ISM__LANES-th VPL. Each lane has memory of its own for shares. */
static void ism__points_task(void *context, size_t lane)
{
    const ism__spread_work *w = (const ism__spread_work *)context;
    ism_maps *m = w->m;
    double *shares = (double *)m->shares.data + lane * ism__lane_shares(w);
    float *effect = (float *)(void *)(shares + w->cluster_count + 1u);
    int pair = m->desc.spread == ISM_SPREAD_PAIR && w->valid_count > 0;
    size_t v;
    for (v = lane; v < m->desc.vpl_count; v += ISM__LANES) {
        if (v == lane || pair)
            ism__share_clusters(w, pair && v < m->vpl_count ? &m->vpls[v] : NULL, effect, shares);
        ism__points_of(w, v, shares);
    }
}

/* Writes for each VPL how many points it has, and how many it had in the frame before, in whose place
   ism__points_of puts how many it made anew. */
static void ism__count_points(ism_maps *m, int fresh)
{
    uint32_t *counts = (uint32_t *)m->counts.data, i;
    double sum = 0.0, mean;
    for (i = 0; i < m->vpl_count; i++) sum += (double)ism__luminance(m->vpls[i].flux);
    mean = m->vpl_count ? sum / (double)m->vpl_count : 0.0;
    for (i = 0; i < m->desc.vpl_count; i++) {
        double f = i < m->vpl_count ? (double)ism__luminance(m->vpls[i].flux) : mean;
        uint32_t n = m->desc.surfel_count;
        if (m->desc.vary_surfels && f < 0.5 * mean) n = f < 0.25 * mean ? n / 4u : n / 2u;
        counts[2u * i + 1u] = fresh ? 0 : counts[2u * i];
        counts[2u * i] = n;
    }
}

/* Finds the sphere that maps of directions show. */
static void ism__bounding_sphere(ism_maps *m, const ism_mesh *mesh)
{
    ism__v3 lo = ism__v3_make(1e30f, 1e30f, 1e30f), hi = ism__v3_make(-1e30f, -1e30f, -1e30f), c;
    size_t i;
    for (i = 0; mesh && i < mesh->vertex_count; i++) {
        ism__v3 p = ism__v3_load(ism__at(mesh->positions, mesh->vertex_stride, i));
        if (!ism__v3_finite(p) || fabsf(p.x) > 1e18f || fabsf(p.y) > 1e18f || fabsf(p.z) > 1e18f) continue;
        lo = ism__v3_min(lo, p);
        hi = ism__v3_max(hi, p);
    }
    if (!(lo.x <= hi.x)) lo = hi = ism__v3_make(0, 0, 0);
    c = ism__v3_scale(ism__v3_add(lo, hi), 0.5f);
    ism__v3_store(m->center, c);
    m->radius = 0.5f * ism__v3_length(ism__v3_sub(hi, lo)) * 1.001f + 1e-20f;
}

/* Makes room for the points and for the distributions from which they are drawn. Returns 0 if there is no
   memory. */
static int ism__hold_points(ism_maps *m, ism__spread_work *w)
{
    const size_t vpls = m->desc.vpl_count, bundles = w->cluster_count / ISM__BUNDLE + 1u;
    if (!ism__grow(m, &m->weights, w->triangles, 2u * sizeof(float)) ||
        !ism__grow(m, &m->clusters, bundles, sizeof(ism__clusters) + ISM__BUNDLE * sizeof(double)) ||
        !ism__grow(m, &m->shares, ISM__LANES * ism__lane_shares(w), sizeof(double)) ||
        !ism__grow(m, &m->sums, w->triangles + 1u, sizeof(double)) ||
        !ism__grow(m, &m->surfels, vpls * m->desc.surfel_count, sizeof(ism__surfel)) ||
        !ism__grow(m, &m->counts, vpls * 2u, sizeof(uint32_t)))
        return 0;
    w->valid = (const uint32_t *)m->pixels.data;
    w->area = (float *)m->weights.data;
    w->solid = w->area + w->triangles;
    w->seen = (double *)m->clusters.data;
    w->clusters = (ism__clusters *)(void *)(w->seen + bundles * ISM__BUNDLE);
    memset(w->clusters + bundles - 1u, 0, sizeof *w->clusters);     /* kernels read the whole last bundle */
    return 1;
}

/* Makes the surfels of a frame: triangles are weighed, then clusters of them, then points are drawn. */
static ism_result ism__renew_points(ism_maps *m, const ism__job *job)
{
    const ism_frame *f = job->frame;
    ism__spread_work w;
    double area = 0.0, solid = 0.0;
    size_t t;
    ism_result result;
    memset(&w, 0, sizeof w);
    w.m = m;
    w.mesh = f->mesh;
    w.view = &job->view;
    w.triangles = ism__mesh_triangles(f->mesh);
    w.frame = f->index;
    w.period = m->desc.unstable ? 1u : m->desc.lazy_frames;
    w.fresh = !m->triangles;
    w.fewer = w.triangles < m->triangles;
    ism__choose_spread(&w);
    if (w.triangles >= 1u << 31) {
        ism__log_value(&job->log, "the mesh's count of triangles", (double)w.triangles, "below 2^31");
        return ISM_ERR_LIMIT;
    }
    w.cluster_size = (uint32_t)(w.triangles / ISM__CLUSTERS) + 1u;
    w.cluster_count = (uint32_t)((w.triangles + w.cluster_size - 1u) / w.cluster_size);
    result = ism__valid_pixels(m, &job->view, &w.valid_count);
    if (result == ISM_ERR_ALLOC) return ism__no_memory(&job->log);
    if (result != ISM_OK) return result;
    if (!ism__hold_points(m, &w)) return ism__no_memory(&job->log);
    if (!ism__run(m, &job->part, 0.1f, 0.4f, (w.triangles + ISM__TRIANGLES - 1u) / ISM__TRIANGLES,
                  ism__spread_task, &w))
        return ISM_ERR_CANCELLED;
    m->stats.skipped_triangles = 0;
    for (t = 0; t < w.triangles; t++) {
        if (w.area[t] < 0.0f) return ism__check_indices(&job->log, f->mesh);
        m->stats.skipped_triangles += w.area[t] > 0.0f ? 0u : 1u;
        area += (double)w.area[t];
        solid += (double)w.solid[t];
    }
    m->stats.surface_area = area;
    m->stats.surfels = m->stats.renewed = 0;
    if (!(area > 0.0)) {
        m->triangles = 0;
        return ISM_OK;
    }
    ism__make_cdf(&w, area, solid);
    if (!ism__run(m, &job->part, 0.4f, 0.5f, w.cluster_count, ism__cluster_task, &w))
        return ISM_ERR_CANCELLED;
    ism__count_points(m, w.fresh);
    m->triangles = 0;               /* set once all points are made: a cancelled renewal begins anew */
    if (!ism__run(m, &job->part, 0.5f, 1.0f, ISM__LANES, ism__points_task, &w)) return ISM_ERR_CANCELLED;
    m->triangles = w.triangles;
    for (t = 0; t < 2u * (size_t)m->desc.vpl_count; t++)
        *(t & 1u ? &m->stats.renewed : &m->stats.surfels) += ((const uint32_t *)m->counts.data)[t];
    return ISM_OK;
}

/* Makes surfels and windows, without maps. */
static ism_result ism__scatter(ism_maps *m, const ism__job *job)
{
    const ism_frame *f = job->frame;
    ism_result result = f->mesh ? ism__check_mesh(&job->log, f->mesh) : ISM_OK;
    if (result == ISM_OK && f->mesh) result = ism__check_opacities(&job->log, f->mesh);
    if (result != ISM_OK) return result;
    m->built = 0;
    if (!ism__grow(m, &m->windows, m->desc.vpl_count, sizeof(ism__window) + sizeof(uint32_t)))
        return ism__no_memory(&job->log);
    ism__bounding_sphere(m, f->mesh);
#ifndef ISM_WITHOUT_WINDOWS
    if (!ism__make_windows(m, &job->view, &job->part)) return ISM_ERR_CANCELLED;
#else
    memset(m->windows.data, 0, m->desc.vpl_count * sizeof(ism__window));
#endif
    return ism__renew_points(m, job);
}

/* Logs what the call needs and the maps do not have yet, and returns ISM_ERR_ORDER. */
static ism_result ism__too_early(const ism__logger *log, const char *name, const char *needs)
{
    ism__log_text(log, name, needs);
    return ISM_ERR_ORDER;
}

ISM_DEF ism_result ism_scatter(ism_maps *m, const ism_frame *f)
{
    ism__job job;
    ism_result result = ism__open_frame(m, f, "ism_scatter", &job);
    if (result != ISM_OK) return result;
    return m->chosen ? ism__scatter(m, &job)
                     : ism__too_early(&job.log, "maps", "have no VPLs: call ism_choose before");
}

static ism_surfel ism__unpack_surfel(const ism__surfel *p)
{
    ism_surfel out;
    out.triangle = p->triangle;
    out.barycentric[0] = (float)p->b1 * (1.0f / 65535.0f);
    out.barycentric[1] = (float)p->b2 * (1.0f / 65535.0f);
    out.area = p->weight;
    return out;
}

static ism_result ism__no_surfels(const ism__logger *log)
{
    return ism__too_early(log, "maps", "have no surfels: call ism_build before, with a mesh");
}

ISM_DEF ism_result ism_surfels(const ism_maps *m, uint32_t vpl, ism_surfel *out, size_t capacity,
                               size_t *count)
{
    const ism__surfel *points;
    uint32_t n, j;
    ism__job job;
    if (!m) return ISM_ERR_ARGUMENT;
    ism__begin_job(&m->desc.system, "ism_surfels", NULL, &job);
    if (ism__check_list(&job.log, out, capacity, count) != ISM_OK) return ISM_ERR_ARGUMENT;
    if (vpl >= m->desc.vpl_count) {
        ism__log_value(&job.log, "vpl", (double)vpl, "below desc.vpl_count");
        return ISM_ERR_ARGUMENT;
    }
    if (!m->triangles) return ism__no_surfels(&job.log);
    points = (const ism__surfel *)m->surfels.data + (size_t)vpl * m->desc.surfel_count;
    n = ((const uint32_t *)m->counts.data)[2u * vpl];
    for (j = 0; j < n && j < capacity; j++) out[j] = ism__unpack_surfel(&points[j]);
    *count = n;
    return ISM_OK;
}

ISM_DEF ism_result ism_phase_surfels(const ism_maps *m, uint32_t phase, ism_surfel *out, size_t capacity,
                                     size_t *count)
{
    uint32_t each, v, j;
    size_t k = 0;
    ism__job job;
    if (!m) return ISM_ERR_ARGUMENT;
    ism__begin_job(&m->desc.system, "ism_phase_surfels", NULL, &job);
    if (ism__check_list(&job.log, out, capacity, count) != ISM_OK) return ISM_ERR_ARGUMENT;
    if (phase >= m->desc.lazy_frames) {
        ism__log_value(&job.log, "phase", (double)phase, "below desc.lazy_frames");
        return ISM_ERR_ARGUMENT;
    }
    if (!m->triangles) return ism__no_surfels(&job.log);
    each = (m->desc.surfel_count + m->desc.lazy_frames - 1u) / m->desc.lazy_frames;
    *count = (size_t)m->desc.vpl_count * each;
    for (v = 0; v < m->desc.vpl_count; v++) {
        const ism__surfel *points = (const ism__surfel *)m->surfels.data + (size_t)v * m->desc.surfel_count;
        uint32_t n = ((const uint32_t *)m->counts.data)[2u * v];
        for (j = 0; j < each && k < capacity; j++, k++) {
            uint32_t i = phase + j * m->desc.lazy_frames;
            memset(&out[k], 0, sizeof *out);
            if (i < n) out[k] = ism__unpack_surfel(&points[i]);
        }
    }
    return ISM_OK;
}

/* ==== src/ism/splat.h ==== */

/* ---- splat: points are fetched, and drawn as discs into one tile (paper 3.3) ---- */

/* Has the corners of the point ISM__AHEAD places on fetched, and the indices of the one twice as far: points
   lie in the mesh's order, but so far apart that the processor does not foresee the next. */
ISM__INLINE void ism__read_ahead(const ism_mesh *mesh, const ism__surfel *points, uint32_t count, uint32_t j)
{
    uint32_t k;
    if (mesh->indices && j + 2u * ISM__AHEAD < count) {
        const uint32_t *at = mesh->indices + 3u * (size_t)points[j + 2u * ISM__AHEAD].triangle;
        ISM__PREFETCH(at);
        ISM__PREFETCH(at + 2);
    } else if (mesh->indices16 && j + 2u * ISM__AHEAD < count) {
        ISM__PREFETCH(mesh->indices16 + 3u * (size_t)points[j + 2u * ISM__AHEAD].triangle);
    }
    if (j + ISM__AHEAD >= count) return;
    for (k = 0; k < 3u; k++) {
        size_t i = 3u * (size_t)points[j + ISM__AHEAD].triangle + k;
        const float *at = ism__at(mesh->positions, mesh->vertex_stride, ism__index(mesh, i));
        ISM__PREFETCH(at);
        ISM__PREFETCH(at + 2);
    }
}

/* Adds a point to those that wait to be drawn. */
static void ism__add_point(const ism_mesh *mesh, const ism__surfel *point, ism__discs *s)
{
    uint32_t i = s->count++, k;
    s->triangle[i] = point->triangle;
    s->weight[i] = point->weight;
    s->b1[i] = (float)point->b1 * (1.0f / 65535.0f);
    s->b2[i] = (float)point->b2 * (1.0f / 65535.0f);
    for (k = 0; k < 3u; k++) {
        const float *p = ism__at(mesh->positions, mesh->vertex_stride,
                                 ism__index(mesh, 3u * (size_t)point->triangle + k));
        s->corners[k][0][i] = p[0];
        s->corners[k][1][i] = p[1];
        s->corners[k][2][i] = p[2];
    }
}

/* Draws the points of VPL `number` into its tile, ISM__DISCS together. */
static void ism__draw_points(ism__tile *tile, const ism__splat *kernels, const ism__surfel *points,
                             uint32_t count, uint32_t number)
{
    const ism_mesh *mesh = tile->mesh;
    uint32_t j, column = number % tile->m->tiles, row = number / tile->m->tiles;
    ism__discs discs;
    memset(&discs, 0, sizeof discs);
    for (j = 0; j < count; j++) {
        ism__read_ahead(mesh, points, count, j);
        /* Opacity is dithered over 2 x 2 tiles, not texels: pull and push would close the gaps that dithering
           leaves. Points in holes have no weight. */
        if (points[j].weight > 0.0f &&
            (!mesh->opacities || ism__dither(column, row, mesh->opacities[points[j].triangle])))
            ism__add_point(mesh, &points[j], &discs);
        if (discs.count < ISM__DISCS && j + 1u < count) continue;
        kernels->draw(tile, &discs, kernels->place(tile, &discs));
        discs.count = 0;
    }
}

/* ==== src/ism/fill.h ==== */

/* ---- fill: pull and push (paper 3.3), after Marroquim et al. 2007 ---- */

/* Returns the bit of the quadrant about a texel in which (dx, dy) lies; each quadrant owns one half axis. */
static uint32_t ism__quadrant(int dx, int dy)
{
    return dx > 0 && dy >= 0 ? 1u : dx <= 0 && dy > 0 ? 2u : dx < 0 ? 4u : 8u;
}

/* Returns the bit of the sector about a texel in which (dx, dy) lies. The eight sectors have 45 degrees each,
   with the axes and diagonals in their middles. */
static uint32_t ism__sector(int dx, int dy)
{
    int ax = dx < 0 ? -dx : dx, ay = dy < 0 ? -dy : dy;
    if (12 * ay < 5 * ax) return dx > 0 ? 1u : 16u;                         /* about tan 22.5 */
    if (12 * ax < 5 * ay) return dy > 0 ? 4u : 64u;
    return dx > 0 ? (dy > 0 ? 2u : 128u) : dy > 0 ? 8u : 32u;
}

/* Returns a set of sectors turned by so many sectors. */
static uint32_t ism__rotate_sectors(uint32_t sectors, uint32_t by)
{
    return (sectors << by | sectors >> (8u - by)) & 255u;
}

/* Returns whether a texel is surrounded, given the sectors about it in which surfels were found. What lies on
   one side of a line touches five sectors at most, so a texel is surrounded if no three sectors in a row are
   empty. Sectors beyond the tile's border count as full if there are surfels along the border on both sides
   of the texel: in the sector next to those beyond or, of surfels that are close, one farther. */
static int ism__surrounded(uint32_t found, uint32_t close, uint32_t beyond)
{
    uint32_t along = (ism__rotate_sectors(beyond, 1) | ism__rotate_sectors(beyond, 7)) & ~beyond, open;
    close = ism__rotate_sectors(close, 1) | ism__rotate_sectors(close, 7);
    if (((found | close) & along) == along) found |= beyond;
    open = ~found & 255u;
    return (open & ism__rotate_sectors(open, 1) & ism__rotate_sectors(open, 2)) == 0;
}

/* Returns whether the plane of the nearer surfel at texel n passes before texel c, which is this deep. */
static int ism__passes_before(const ism__tile *tile, size_t n, size_t c, float depth)
{
    float t;
    if (!(tile->depth[n] < 0.9f * depth)) return 0;
    t = ism__plane_depth(tile, tile->texels[n].g, c);
    return t > 0.5f * tile->depth[n] && t < 0.95f * depth;
}

/* Returns in which quadrants about a texel there are nearer surfels whose planes pass before the texel. There
   may be such surfels beyond the tile's border, so what lies there counts. */
static uint32_t ism__quadrants_before(const ism__tile *tile, int x, int y)
{
    int size = (int)tile->size, dx, dy;
    size_t c = (size_t)(y * size + x);
    uint32_t found = 0;
    for (dy = -ISM__HOLE; dy <= ISM__HOLE; dy++)
        for (dx = -ISM__HOLE; dx <= ISM__HOLE; dx++) {
            int outside = x + dx < 0 || y + dy < 0 || x + dx >= size || y + dy >= size;
            if (dx == 0 && dy == 0) continue;
            if (outside || ism__passes_before(tile, (size_t)((y + dy) * size + x + dx), c, tile->depth[c]))
                found |= ism__quadrant(dx, dy);
        }
    return found;
}

/* A texel with nearer surfels in all four quadrants about it, whose planes pass before it, is a hole between
   them through which something hidden is seen: it is emptied, for pull and push to close. Holes are marked by
   UINT32_MAX first, so that none depends on another. */
static void ism__open_holes(ism__tile *tile)
{
    size_t i, size = tile->size, count = size * size;
    for (i = 0; i < count; i++)
        if (tile->depth[i] < ISM_FAR && ism__quadrants_before(tile, (int)(i % size), (int)(i / size)) == 15u)
            tile->texels[i].triangle = UINT32_MAX;
    for (i = 0; i < count; i++)
        if (tile->texels[i].triangle == UINT32_MAX) tile->depth[i] = ISM_FAR;
}

/* Returns 1 + the index of the texel that cell (x, y) of a level holds, or 0 if the cell is empty. Level 0 is
   the tile itself, `below` the cells of another level. */
static uint32_t ism__pulled(const ism__tile *tile, const uint32_t *below, uint32_t level, uint32_t x,
                            uint32_t y)
{
    size_t i = (size_t)y * (tile->size >> level) + x;
    if (level > 0) return below[i];
    return tile->depth[i] < ISM_FAR ? (uint32_t)i + 1u : 0;
}

/* Returns which texel of its four cells a cell of a coarser level keeps: the nearest to its middle. */
static uint32_t ism__pull_cell(const ism__tile *tile, const uint32_t *below, uint32_t level, uint32_t x,
                               uint32_t y)
{
    uint32_t best = 0, least = UINT32_MAX, k;
    uint32_t mx = (2u * x + 1u) << level, my = (2u * y + 1u) << level;
    for (k = 0; k < 4u; k++) {
        uint32_t at = ism__pulled(tile, below, level - 1u, 2u * x + (k & 1u), 2u * y + (k >> 1)), px, py, d;
        if (!at) continue;
        px = 2u * ((at - 1u) % tile->size) + 1u;
        py = 2u * ((at - 1u) / tile->size) + 1u;
        d = (px - mx) * (px - mx) + (py - my) * (py - my);
        if (d >= least) continue;
        least = d;
        best = at;
    }
    return best;
}

/* Pulls: makes the coarser levels, one after the other. */
static void ism__pull(const ism__tile *tile, uint32_t *pyramid, uint32_t levels)
{
    uint32_t level, i, *own = pyramid;
    const uint32_t *below = pyramid;
    for (level = 1; level <= levels; level++) {
        uint32_t side = tile->size >> level;
        for (i = 0; i < side * side; i++) own[i] = ism__pull_cell(tile, below, level, i % side, i / side);
        below = own;
        own += side * side;
    }
}

/* Returns the depth that an empty texel takes from the two surfels nearest to it: the first one's depth, or
   that of the first one's plane at this texel, whichever would have foretold the second one better. No depth
   is ever mixed with another. */
static float ism__push(const ism__tile *tile, size_t i, size_t first, size_t second)
{
    const float *g = tile->texels[first].g;
    float t = ism__plane_depth(tile, g, i), there = ism__plane_depth(tile, g, second);
    float own = tile->depth[first], next = tile->depth[second];
    if (fabsf(own - next) <= fabsf(there - next)) return own;
    return t > 0.5f * own && t < 2.0f * own ? t : own;
}

/* The surroundings of an empty texel, as far as they were read: from finer to coarser levels. */
typedef struct ism__search {
    ism__texel *first, *second;     /* the two nearest surfels' texels, or NULL */
    int         least, next;        /* their squared distances in texels */
    uint32_t    found, beyond;      /* sectors in which there are surfels; those beyond the tile's border */
} ism__search;

/* Takes a surfel's texel into account, at this squared distance. */
static void ism__keep_nearest(ism__search *s, ism__texel *texel, int d)
{
    if (!s->first || d < s->least) {
        if (s->first && s->first != texel) {
            s->second = s->first;
            s->next = s->least;
        }
        s->first = texel;
        s->least = d;
    } else if (s->first != texel && (!s->second || d < s->next)) {
        s->second = texel;
        s->next = d;
    }
}

/* Reads the 3 x 3 cells of one level of the pyramid about texel tx, ty. */
static void ism__search_level(const ism__tile *tile, const uint32_t *cells, uint32_t level, int tx, int ty,
                              ism__search *s)
{
    int half = (int)(tile->size >> level), cx = tx >> level, cy = ty >> level;
    int x, y;
    for (y = cy - 1; y <= cy + 1; y++)
        for (x = cx - 1; x <= cx + 1; x++) {
            uint32_t at;
            int dx, dy;
            if (x < 0 || y < 0 || x >= half || y >= half) {
                s->beyond |= ism__sector(x - cx, y - cy);
                continue;
            }
            at = cells[y * half + x];
            if (!at) continue;
            dx = (int)((at - 1u) % tile->size) - tx;
            dy = (int)((at - 1u) / tile->size) - ty;
            s->found |= ism__sector(dx, dy);
            ism__keep_nearest(s, &tile->texels[at - 1u], dx * dx + dy * dy);
        }
}

/* Closes holes, and pushes: an empty texel looks at the 3 x 3 cells about it, level by level, and takes a
   depth from the nearest surfels once it is surrounded. A texel outside a silhouette never is, and stays
   empty. Nothing is read beyond the tile. */
static void ism__fill(ism__tile *tile, uint32_t *pyramid)
{
    uint32_t size = tile->size, level, levels = 3u;
    size_t i, texels = (size_t)size * size;
    ism__open_holes(tile);
    while (size >> levels < 2u) levels--;
    ism__pull(tile, pyramid, levels);
    for (i = 0; i < texels; i++) {
        ism__texel *to = &tile->texels[i];
        ism__search s = { NULL, NULL, 0, 0, 0, 0 };
        uint32_t close = 0;
        size_t offset = 0;
        if (tile->depth[i] < ISM_FAR) continue;
        to->filled = 0;
        for (level = 1; level <= levels; level++) {
            if (s.second && ism__surrounded(s.found, close, s.beyond)) break;
            ism__search_level(tile, pyramid + offset, level, (int)(i % size), (int)(i / size), &s);
            offset += (size_t)(size >> level) * (size >> level);
            if (level == 1) close = s.found;
        }
        if (!s.second || !ism__surrounded(s.found, close, s.beyond)) continue;
        to->g[0] = ism__push(tile, i, (size_t)(s.first - tile->texels), (size_t)(s.second - tile->texels));
        to->triangle = s.first->triangle;
        to->filled = 1;     /* the tile's own depth stays ISM_FAR: no texel is filled from this one */
        tile->filled++;
    }
}

/* ==== src/ism/atlas.h ==== */

/* ---- atlas: the tiles of all VPLs ---- */

typedef struct ism__atlas_work {
    ism_maps       *m;
    const ism_mesh *mesh;
    uint32_t        lanes;
    ism__splat      kernels;
} ism__atlas_work;

/* Returns the memory in which a lane draws tiles: texels, depths, directions, the pyramid of pull and push,
   and counts. */
static size_t ism__lane_bytes(uint32_t size)
{
    size_t texels = (size_t)size * size;
    return texels * sizeof(ism__texel) + texels * 4u * sizeof(float) + texels * sizeof(uint16_t) + 64u;
}

/* Writes the directions of a tile's texel centres: all x, then all y, then all z. */
static void ism__tile_directions(const ism__tile *tile, float *out)
{
    size_t texels = (size_t)tile->size * tile->size, k;
    uint32_t x, y;
    for (y = 0; y < tile->size; y++)
        for (x = 0; x < tile->size; x++, out++) {
            float uv[2], w[3];
            uv[0] = ((float)x + 0.5f) / (float)tile->size;
            uv[1] = ((float)y + 0.5f) / (float)tile->size;
            if (tile->window) {
                uv[0] = ism__from_tile(&tile->window->u, uv[0]);
                uv[1] = ism__from_tile(&tile->window->v, uv[1]);
            }
            if (tile->vpl->directional) {
                w[0] = 2.0f * uv[0] - 1.0f;
                w[1] = 2.0f * uv[1] - 1.0f;
                w[2] = 1.0f;
            } else {
                ism_map_direction(tile->projection, tile->vpl->exponent, uv, w);
            }
            for (k = 0; k < 3u; k++) out[k * texels] = w[k];
        }
}

/* Begins a tile, in the lane's memory. Directions are those that all tiles share, unless this tile's texels
   look elsewhere: then they are computed. */
static void ism__begin_tile(ism__tile *tile, const ism__atlas_work *w, uint32_t v, char *scratch)
{
    ism_maps *m = w->m;
    size_t texels = (size_t)m->desc.tile_side * m->desc.tile_side, i;
    const float *directions = (const float *)m->directions.data;
    float *own;
    memset(tile, 0, sizeof *tile);
    tile->m = m;
    tile->mesh = w->mesh;
    tile->vpl = &m->vpls[v];
    tile->axes = ism__vpl_axes(m, tile->vpl);
    tile->projection = ism__projection_of(m, tile->vpl);
    tile->size = m->desc.tile_side;
    tile->window = (const ism__window *)m->windows.data + v;
    tile->texels = (ism__texel *)(void *)scratch;
    tile->depth = (float *)(void *)(scratch + texels * sizeof(ism__texel));
    own = tile->depth + texels;
    if (tile->window->u.on || tile->window->v.on || tile->vpl->directional ||
        tile->projection == ISM_PROJECTION_LOBE) {
        ism__tile_directions(tile, own);
        directions = own;
    }
    tile->x = directions;
    tile->y = directions + texels;
    tile->z = directions + 2u * texels;
    for (i = 0; i < texels; i++) {
        tile->depth[i] = ISM_FAR;
        tile->texels[i].triangle = 0;
    }
    tile->texels_per_unit = ism__texels_per_unit(tile);
}

/* Copies a tile into the atlas. */
static void ism__end_tile(const ism__tile *tile, ism_maps *m, uint32_t v)
{
    size_t column = v % m->tiles, row = v / m->tiles, x, y;
    for (y = 0; y < tile->size; y++)
        for (x = 0; x < tile->size; x++) {
            const ism__texel *from = &tile->texels[y * tile->size + x];
            float depth = tile->depth[y * tile->size + x];
            size_t to = (row * tile->size + y) * m->side + column * tile->size + x;
            int full = depth < ISM_FAR, filled = !full && !m->desc.no_fill && from->filled;
            ((float *)m->atlas.data)[to] = full ? depth : filled ? from->g[0] : ISM_FAR;
            if (m->hits.data) ((uint32_t *)m->hits.data)[to] = full || filled ? from->triangle : UINT32_MAX;
        }
}

/* Empties the tiles that no VPL has, as far as VPLs of the frame before, or the allocator, left something
   there. */
static void ism__blank_tiles(ism_maps *m)
{
    size_t v, size = m->desc.tile_side, x, y;
    for (v = m->vpl_count; v < m->blank_from; v++)
        for (y = 0; y < size; y++)
            for (x = 0; x < size; x++) {
                size_t to = (v / m->tiles * size + y) * m->side + v % m->tiles * size + x;
                ((float *)m->atlas.data)[to] = ISM_FAR;
                if (m->hits.data) ((uint32_t *)m->hits.data)[to] = UINT32_MAX;
            }
    m->blank_from = m->vpl_count;
}

#ifndef ISM_WITHOUT_FILL
/* Returns where pull and push have their levels: after depths and directions. */
static uint32_t *ism__pyramid_of(const ism__tile *tile)
{
    return (uint32_t *)(void *)(tile->depth + (size_t)tile->size * tile->size * 4u);
}
#endif

/* Draws the tiles of every so many-th VPL, one after the other. */
static void ism__lane_task(void *context, size_t lane)
{
    const ism__atlas_work *w = (const ism__atlas_work *)context;
    ism_maps *m = w->m;
    char *scratch = (char *)m->scratch.data + lane * ism__lane_bytes(m->desc.tile_side);
    uint64_t *stats = (uint64_t *)(void *)(scratch + ism__lane_bytes(m->desc.tile_side) - 64u);
    size_t v;
    stats[0] = stats[1] = stats[2] = 0;
    for (v = lane; v < m->vpl_count; v += w->lanes) {
        ism__tile tile;
        ism__begin_tile(&tile, w, (uint32_t)v, scratch);
        if (m->triangles)
            ism__draw_points(&tile, &w->kernels,
                             (const ism__surfel *)m->surfels.data + v * m->desc.surfel_count,
                             ((const uint32_t *)m->counts.data)[2u * v], (uint32_t)v);
#ifndef ISM_WITHOUT_FILL
        if (!m->desc.no_fill) ism__fill(&tile, ism__pyramid_of(&tile));
#endif
        ism__end_tile(&tile, m, (uint32_t)v);
        stats[0] += tile.splats;
        stats[1] += tile.wide;
        stats[2] += tile.filled;
    }
}

static ism_result ism__build(ism_maps *m, const ism__job *job)
{
    ism__atlas_work w;
    ism__job first = *job;
    size_t texels, i;
    ism_result result;
    w.m = m;
    w.mesh = job->frame->mesh;
    w.kernels = ism__choose_splat();
    w.lanes = m->vpl_count < ISM__LANES ? m->vpl_count : ISM__LANES;
    texels = (size_t)m->side * m->side;
    if (!ism__grow(m, &m->atlas, texels, sizeof(float)) ||
        (m->desc.keep_hits && !ism__grow(m, &m->hits, texels, sizeof(uint32_t))) ||
        !ism__grow(m, &m->scratch, ISM__LANES, ism__lane_bytes(m->desc.tile_side)))
        return ism__no_memory(&job->log);
    first.part = ism__part_of(&job->part, 0.0f, 0.5f);
    result = ism__scatter(m, &first);
    if (result != ISM_OK) return result;
    ism__blank_tiles(m);
    if (w.lanes && !ism__run(m, &job->part, 0.5f, 1.0f, w.lanes, ism__lane_task, &w))
        return ISM_ERR_CANCELLED;
    m->stats.splats = m->stats.wide_splats = m->stats.filled = 0;
    for (i = 0; i < w.lanes; i++) {
        const char *end = (const char *)m->scratch.data + (i + 1u) * ism__lane_bytes(m->desc.tile_side);
        const uint64_t *stats = (const uint64_t *)(const void *)(end - 64u);
        m->stats.splats += stats[0];
        m->stats.wide_splats += stats[1];
        m->stats.filled += stats[2];
    }
    m->built = 1;
    return ISM_OK;
}

ISM_DEF ism_result ism_build(ism_maps *m, const ism_frame *f)
{
    ism__job job;
    ism_result result = ism__open_frame(m, f, "ism_build", &job);
    if (result != ISM_OK) return result;
    return m->chosen ? ism__build(m, &job)
                     : ism__too_early(&job.log, "maps", "have no VPLs: call ism_choose before");
}

ISM_DEF const float *ism_atlas(const ism_maps *m, uint32_t *side, uint32_t *tiles_across)
{
    if (!m || !m->built) return NULL;
    if (side) *side = m->side;
    if (tiles_across) *tiles_across = m->tiles;
    return (const float *)m->atlas.data;
}

/* ==== src/ism/kernels.h ==== */

/* ---- kernels: light from one VPL or near point to a receiver, unshadowed ---- */

typedef struct ism__shade_work {
    const ism_maps    *m;
    const ism__view    *view;
    ism_shading        s;
    uint32_t           interleave, blocks_x;
    const uint32_t    *order;       /* numbers of the VPLs, class by class */
    const uint32_t    *class_first; /* where in `order` each of the interleave^2 classes begins; the end */
    const float       *fields;      /* ISM__FIELDS arrays of vpl_count, in `order` */
    const ism__orientation *axes;   /* axes of the VPLs' maps, in `order` */
    float             *light;       /* irradiance, 3 a pixel */
    float             *blurred;     /* the same after the blur */
    double            *lost;        /* four of each block: light that the rule near by took off, light before
                                       that, pairs that were culled, all pairs */
} ism__shade_work;

typedef struct ism__pixel { ism__v3 p, n, ng; } ism__pixel;

/* Returns the light of a unit of flux from a square of the VPL's area about the VPL. The square is cut at the
   receiver's horizon, and the part that is left sends the whole flux, since a surface does not go on behind
   the one it meets. A receiver that faces the square (fully from 120 degrees between the normals on) gets no
   more than from a point: it may be the back of a bent sheet close above the lit surface, to which the square
   reaches out, and depths cannot tell the two apart. *square is the light without this rule. */
static float ism__patch_kernel(const ism__orientation *f, ism__v3 d, ism__v3 n, float edge, float point,
                               float *square)
{
    ism__v3 c[4], x = ism__v3_scale(f->x, 0.5f * edge), y = ism__v3_scale(f->y, 0.5f * edge);
    float share, form, facing = -2.0f * ism__v3_dot(n, f->z);
    c[0] = ism__v3_sub(ism__v3_sub(d, x), y);
    c[1] = ism__v3_sub(ism__v3_add(d, x), y);
    c[2] = ism__v3_add(ism__v3_add(d, x), y);
    c[3] = ism__v3_add(ism__v3_sub(d, x), y);
    form = ism__form_factor(n, c, 4, &share);
    *square = form = form > 0.0f && share > 0.0f ? form * ISM__PI / (edge * edge * share) : 0.0f;
    if (!(facing > 0.0f) || !(form > point)) return form;
    return form + (facing < 1.0f ? facing : 1.0f) * (point - form);
}

/* Returns the light of a unit of flux from a virtual spherical light: the mean of both cosines over the cone
   that the sphere fills, whose radius is that of a disc of the VPL's area. After Hasan et al., "Virtual
   spherical lights for many-light rendering of glossy scenes", 2009. */
static float ism__sphere_kernel(ism__v3 d, ism__v3 normal, ism__v3 n, float edge)
{
    float r2 = edge * edge * (1.0f / ISM__PI), d2 = ism__v3_dot(d, d), least, sum = 0.0f;
    ism__v3 z = ism__v3_normalize(d), x, y;
    uint32_t k;
    least = d2 > r2 ? sqrtf(1.0f - r2 / d2) : -1.0f;
    ism__v3_basis(z, &x, &y);
    for (k = 0; k < 16u; k++) {
        float cosine = 1.0f - (1.0f - least) * ((float)k + 0.5f) * (1.0f / 16.0f),
              sine = sqrtf(1.0f - cosine * cosine);
        float s, c, a, b;
        ism__v3 w;
        ism__sincos(2.39996323f * (float)k, &s, &c);
        w = ism__v3_madd(ism__v3_madd(ism__v3_scale(z, cosine), x, sine * c), y, sine * s);
        a = ism__v3_dot(n, w);
        b = -ism__v3_dot(normal, w);
        if (a > 0.0f && b > 0.0f) sum += a * b;
    }
    return sum * (1.0f / 16.0f) * 2.0f * (1.0f - least) / r2;      /* / (pi r^2) x solid angle */
}

/* Returns which share of the light at this distance comes from near points: all of it within 0.7 reach,
   nothing beyond reach. */
static float ism__nearness(float d2, float reach)
{
    float r2 = reach * reach, h = 2.0f * (r2 - d2);
    return !(h > 0.0f) ? 0.0f : h < r2 ? h / r2 : 1.0f;
}

/* Returns cos cos / d^2 of one VPL, of a direction the cosine, with its lobe and the rule for receivers close
   by. *plain is the same without the light that this rule takes off. */
static float ism__kernel(const ism__shade_work *w, const ism_vpl *v, const ism__orientation *f,
                         const ism__pixel *px, float plain_kernel, float *plain)
{
    ism__v3 d = ism__v3_sub(ism__v3_load(v->position), px->p);
    float d2 = ism__v3_dot(d, d), k = plain_kernel, a2 = v->edge * v->edge, share;
    if (v->directional) {
        k = ism__v3_dot(ism__v3_load(v->position), px->n) * ISM__PI;    /* light is divided by pi
                                                                           afterwards */
        return *plain = k > 0.0f ? k : 0.0f;
    }
    if (v->exponent != 1.0f) {
        float length = sqrtf(d2), c = -ism__v3_dot(ism__v3_load(v->axis), d) / length,
              b = ism__v3_dot(px->n, d) / length;
        k = c > 0.0f && b > 0.0f ? 0.5f * (v->exponent + 1.0f) * ism__pow(c, v->exponent) * b / d2 : 0.0f;
    }
    *plain = k;
    switch (w->s.near_mode) {
    case ISM_NEAR_CLAMP: return k < w->s.clamp ? k : w->s.clamp;
    case ISM_NEAR_SPHERE:
        return a2 > 0.0f && v->exponent == 1.0f && d2 < 16.0f * a2
             ? ism__sphere_kernel(d, ism__v3_load(v->normal), px->n, v->edge) : k;
    case ISM_NEAR_PATCH:
        return a2 > 0.0f && v->exponent == 1.0f && d2 < 9.0f * a2
             ? ism__patch_kernel(f, d, px->n, v->edge, k, plain) : k;
    case ISM_NEAR_GATHER:
        share = 1.0f - ism__nearness(d2, v->reach);
        if (!(share > 0.0f)) return *plain = 0.0f;
        if (a2 > 0.0f && v->exponent == 1.0f && d2 < 9.0f * a2)
            k = ism__patch_kernel(f, d, px->n, v->edge, k, plain);
        *plain *= share;
        return k * share;
    default: return k;
    }
}

/* Writes cos cos / d^2 of consecutive VPLs, 0 where the VPL or the receiver faces away. The loop reads and
   writes plain arrays, so that compilers vectorise it. */
static void ism__kernels(const ism__shade_work *w, const ism__pixel *px, uint32_t first, uint32_t count,
                         float *out)
{
    size_t n = w->m->vpl_count;
    const float *x = w->fields + first, *y = x + n, *z = y + n;
    const float *nx = z + n, *ny = nx + n, *nz = ny + n;
    float px0 = px->p.x, py0 = px->p.y, pz0 = px->p.z;
    float ax = px->n.x, ay = px->n.y, az = px->n.z;
    uint32_t i;
    for (i = 0; i < count; i++) {
        float dx = x[i] - px0, dy = y[i] - py0, dz = z[i] - pz0, d2 = dx * dx + dy * dy + dz * dz;
        float a = ax * dx + ay * dy + az * dz, b = -(nx[i] * dx + ny[i] * dy + nz[i] * dz);
        a = a > 0.0f ? a : 0.0f;
        b = b > 0.0f ? b : 0.0f;
        out[i] = a * b / (d2 * d2 + 1e-37f);
    }
}

/* Returns the mean light, unshadowed, of a class's VPLs at a receiver, with which CLAMP_MEAN compares each.
   */
static float ism__mean_light(const ism__shade_work *w, const ism__pixel *px, uint32_t first, uint32_t end)
{
    float kernels[ISM__CHUNK], sum = 0.0f, plain;
    uint32_t at, i;
    for (at = first; at < end; at += ISM__CHUNK) {
        uint32_t count = end - at < ISM__CHUNK ? end - at : ISM__CHUNK;
        ism__kernels(w, px, at, count, kernels);
        for (i = 0; i < count; i++) {
            const ism_vpl *v = &w->m->vpls[w->order[at + i]];
            sum += ism__kernel(w, v, &w->axes[at + i], px, kernels[i], &plain) * ism__luminance(v->flux);
        }
    }
    return end > first ? sum / (float)(end - first) : 0.0f;
}

/* Returns cos cos / d^2 of a near point's square, times the share that it takes from VPLs at this distance.
   *plain is the same without the light that the square's rule takes off. */
static float ism__near_kernel(const ism_near_point *at, const ism__pixel *px, float *plain)
{
    ism__v3 d = ism__v3_sub(ism__v3_load(at->position), px->p), normal = ism__v3_load(at->normal);
    float d2 = ism__v3_dot(d, d), h = ism__nearness(d2, at->reach), a;
    float b, k;
    if (!(h > 0.0f)) return 0.0f;
    a = ism__v3_dot(px->n, d);
    b = -ism__v3_dot(normal, d);
    if (!(a > 0.0f && b > 0.0f)) return 0.0f;
    *plain = k = a * b / (d2 * d2 + 1e-37f);
    if (d2 < 9.0f * at->edge * at->edge) {
        ism__orientation f;
        f.z = normal;
        ism__v3_basis(f.z, &f.x, &f.y);
        k = ism__patch_kernel(&f, d, px->n, at->edge, k, plain);
    }
    *plain *= h;
    return k * h;
}

/* ==== src/ism/visibility.h ==== */

/* ---- visibility: depths of the tiles compared ---- */

/* Returns where a VPL's tile begins in the atlas. */
static const float *ism__tile_of(const ism_maps *m, uint32_t v)
{
    size_t column = v % m->tiles, row = v / m->tiles;
    return (const float *)m->atlas.data + row * m->desc.tile_side * m->side + column * m->desc.tile_side;
}

/* A receiver as seen from a VPL, before the texel of the map is read. Looks of several VPLs are made
   together, so that their texels, which no cache holds, are fetched meanwhile. */
typedef struct ism__look {
    ism__v3      l, n;              /* the receiver and its normal along the axes of the VPL's map */
    float        d;                 /* distance from the VPL; depth in a map of directions */
    uint32_t     x, y;              /* texel */
    const float *at;                /* the texel's depth; NULL: `lit` is known without it */
    int          lit;
} ism__look;

/* Finds the texel that shows a receiver. A VPL behind the receiver's tangent plane is hidden by the
   receiver's own surface; the depth of a thin sheet could not tell its two sides apart. */
static void ism__look_at(const ism_maps *m, uint32_t number, const ism__orientation *f, ism__v3 p, ism__v3 ng,
                         ism__look *look)
{
    uint32_t size = m->desc.tile_side;
    const ism_vpl *v = &m->vpls[number];
    const ism__window *w = (const ism__window *)m->windows.data + number;
    float uv[2], direction[3];
    look->at = NULL;
    look->n = ism__to_local(f, ng);
    if (v->directional) {
        float r = m->radius;
        look->l = ism__to_local(f, ism__v3_sub(p, ism__v3_load(m->center)));
        look->d = look->l.z + r;
        uv[0] = 0.5f * look->l.x / r + 0.5f;
        uv[1] = 0.5f * look->l.y / r + 0.5f;
        look->lit = look->n.z < -ISM__GRAZING;
        if (!look->lit || !(uv[0] >= 0.0f && uv[1] >= 0.0f && uv[0] < 1.0f && uv[1] < 1.0f)) return;
    } else {
        look->l = ism__to_local(f, ism__v3_sub(p, ism__v3_load(v->position)));
        look->d = ism__v3_length(look->l);
        look->lit = 1;
        if (!(look->l.z > 0.0f) || !(look->d > 0.0f)) return;
        look->lit = ism__v3_dot(look->n, look->l) < -ISM__GRAZING * look->d;
        if (!look->lit) return;
        ism__v3_store(direction, ism__v3_scale(look->l, 1.0f / look->d));
        if (!ism_map_coordinates(ism__projection_of(m, v), v->exponent, direction, uv)) return;
    }
    look->x = ism__texel_of(ism__to_tile(&w->u, uv[0]), size);
    look->y = ism__texel_of(ism__to_tile(&w->v, uv[1]), size);
    look->at = ism__tile_of(m, number) + (size_t)look->y * m->side + look->x;
    ISM__PREFETCH(look->at);
}

/* Returns whether the map lets light through to a receiver. Depths are compared at the centre of the texel,
   on the receiver's own tangent plane: so grazing light leaves no acne. */
static int ism__is_lit(const ism_maps *m, uint32_t number, const ism__look *look, float bias)
{
    uint32_t size = m->desc.tile_side;
    const ism_vpl *v = &m->vpls[number];
    const ism__window *w = (const ism__window *)m->windows.data + number;
    ism__v3 l = look->l, n = look->n;
    float d = look->d, uv[2], direction[3];
    float along, t;
    if (!look->at) return look->lit;
    t = *look->at;
    if (!v->directional && d * (1.0f - bias) <= t && t >= 2.0f * d) return 1;
    uv[0] = ism__from_tile(&w->u, ((float)look->x + 0.5f) / (float)size);
    uv[1] = ism__from_tile(&w->v, ((float)look->y + 0.5f) / (float)size);
    if (v->directional) {
        float r = m->radius, dx = (2.0f * uv[0] - 1.0f) * r - l.x, dy = (2.0f * uv[1] - 1.0f) * r - l.y;
        if (fabsf(n.z) > 0.1f) d -= (n.x * dx + n.y * dy) / n.z;
        return d - bias * r <= t;
    }
    if (0.5f * d * (1.0f - bias) > t) return 0;     /* the plane's depth, below, is at least 0.5 d */
    if (ism__projection_of(m, v) != ISM_PROJECTION_LOBE && !w->u.on && !w->v.on) {
        const float *at = (const float *)m->directions.data + (size_t)look->y * size + look->x;
        size_t texels = (size_t)size * size;
        direction[0] = at[0];
        direction[1] = at[texels];
        direction[2] = at[2u * texels];
    } else {
        ism_map_direction(ism__projection_of(m, v), v->exponent, uv, direction);
    }
    along = n.x * direction[0] + n.y * direction[1] + n.z * direction[2];
    along = along != 0.0f ? ism__v3_dot(n, l) / along : d;
    if (along > 0.5f * d && along < 2.0f * d) d = along;
    return d * (1.0f - bias) <= t;
}

static int ism__lit(const ism_maps *m, uint32_t number, const ism__orientation *f, ism__v3 p, ism__v3 ng,
                    float bias)
{
    ism__look look;
    ism__look_at(m, number, f, p, ng, &look);
    return ism__is_lit(m, number, &look, bias);
}

/* Returns the bias of a setting: 0 is the default, a negative number is none. */
static float ism__bias_of(float bias) { return bias > 0.0f ? bias : bias < 0.0f ? 0.0f : 0.02f; }

ISM_DEF ism_result ism_visible(const ism_maps *m, uint32_t vpl, const ism_points *points, float bias,
                               float *visible)
{
    ism__orientation axes;
    ism__job job;
    ism_result result;
    size_t i;
    if (!m) return ISM_ERR_ARGUMENT;
    ism__begin_job(&m->desc.system, "ism_visible", NULL, &job);
    if (!visible) return ism__is_null(&job.log, "visible");
    if (vpl >= m->vpl_count || !(bias < 1.0f)) {
        if (vpl >= m->vpl_count) ism__log_value(&job.log, "vpl", (double)vpl, "less than there are VPLs");
        else ism__log_value(&job.log, "bias", (double)bias, "less than 1");
        return ISM_ERR_ARGUMENT;
    }
    if (!m->built) return ism__too_early(&job.log, "maps", "are not drawn: call ism_build before");
    result = ism__open_view(&job.log, points, &job.view);
    if (result != ISM_OK) return result;
    axes = ism__vpl_axes(m, &m->vpls[vpl]);
    for (i = 0; i < points->count; i++) {
        ism__v3 p, n;
        visible[i] = 0.0f;
        if (!ism__receiver(&job.view, i, &p, &n)) continue;
        n = ism__geometric_normal(&job.view, i, n);
        visible[i] = (float)ism__lit(m, vpl, &axes, p, n, ism__bias_of(bias));
    }
    return ISM_OK;
}

ISM_DEF void ism_see(void *sight, const float position[3], const float geometric_normal[3],
                     const uint32_t *numbers, size_t count, float *visible)
{
    const ism_sight *s = (const ism_sight *)sight;
    const ism_maps *m = s->maps;
    const ism__v3 p = ism__v3_load(position), ng = ism__v3_load(geometric_normal);
    ism__look looks[ISM__CHUNK];
    size_t first, i, n;
    for (first = 0; first < count; first += n) {
        n = count - first < ISM__CHUNK ? count - first : (size_t)ISM__CHUNK;
        for (i = 0; i < n && m->built; i++) {
            uint32_t v = numbers[first + i];
            ism__orientation axes;
            if (v >= m->vpl_count) continue;
            axes = ism__vpl_axes(m, &m->vpls[v]);
            ism__look_at(m, v, &axes, p, ng, &looks[i]);
        }
        for (i = 0; i < n; i++) {
            uint32_t v = numbers[first + i];
            visible[first + i] = !m->built ? 0.0f
                               : v < m->vpl_count
                                   ? (float)ism__is_lit(m, v, &looks[i], ism__bias_of(s->bias)) : 1.0f;
        }
    }
}

/* Writes the visibility of `count` VPLs; the list has their places in `order`. */
static void ism__visibilities(const ism__shade_work *w, const ism__pixel *px, const uint32_t *list,
                              uint32_t count, float *visible)
{
    uint32_t i, numbers[ISM__CHUNK];
    ism__look looks[ISM__CHUNK];    /* of all VPLs, so that their texels are fetched before one is read */
    if (w->s.visible_fn) {
        float position[3], geometric[3];
        for (i = 0; i < count; i++) numbers[i] = w->order[list[i]];
        ism__v3_store(position, px->p);
        ism__v3_store(geometric, px->ng);
        w->s.visible_fn(w->s.visible_user, position, geometric, numbers, count, visible);
        return;
    }
    for (i = 0; i < count && !w->s.no_maps; i++)
        ism__look_at(w->m, w->order[list[i]], &w->axes[list[i]], px->p, px->ng, &looks[i]);
    for (i = 0; i < count; i++)
        visible[i] = w->s.no_maps ? 1.0f : (float)ism__is_lit(w->m, w->order[list[i]], &looks[i], w->s.bias);
}

/* Returns the axes of the map of VPL v. */
static const ism__orientation *ism__near_axes(const ism__shade_work *w, uint32_t v)
{
    uint32_t classes = w->interleave * w->interleave;
    return &w->axes[w->class_first[v % classes] + v / classes];
}

/* Returns how much of a near point a receiver sees by the map of the point's VPL. Two kinds of receivers
   count as lit beside those that the map shows as lit: one that the map hides, if the point is nearer than
   the VPL and the map, moved to the point, hides nothing, since surfaces are alike around both; and one
   behind the VPL, where the map ends. Neither does if it faces the point, since it may be the back of a bent
   sheet. */
static float ism__near_lit(const ism__shade_work *w, const ism_near_point *at, const ism__pixel *px,
                           const ism__look *look)
{
    const ism_maps *m = w->m;
    uint32_t v = (uint32_t)at->vpl;
    const ism_vpl *l = &m->vpls[v];
    const ism__orientation *f = ism__near_axes(w, v);
    ism__v3 way = ism__v3_sub(ism__v3_load(l->position), ism__v3_load(at->position));
    ism__v3 d = ism__v3_sub(px->p, ism__v3_load(at->position));
    float facing = -2.0f * ism__v3_dot(px->n, ism__v3_load(at->normal));
    float open = !(facing > 0.0f) ? 1.0f : facing < 1.0f ? 1.0f - facing : 0.0f;
    if (!(ism__v3_dot(f->z, ism__v3_sub(px->p, ism__v3_load(l->position))) > 0.0f)) return open;
    if (ism__is_lit(m, v, look, w->s.bias)) return 1.0f;
    if (!(ism__v3_dot(d, d) < ism__v3_dot(way, way) && ism__v3_dot(f->z, d) > 0.0f)) return 0.0f;
    return ism__lit(m, v, f, ism__v3_add(px->p, way), px->ng, w->s.bias) ? open : 0.0f;
}

/* Writes the visibility of `count` near points of the list. */
static void ism__near_visibilities(const ism__shade_work *w, const ism__pixel *px, const uint32_t *list,
                                   uint32_t count, float *visible)
{
    const ism_near_point *points = (const ism_near_point *)w->m->near_points.data;
    ism_visible_fn fn = w->s.near_visible_fn ? w->s.near_visible_fn : w->s.visible_fn;
    uint32_t i, numbers[ISM__CHUNK];
    ism__look looks[ISM__CHUNK];
    if (fn) {
        float position[3], geometric[3];
        for (i = 0; i < count; i++)
            numbers[i] = w->s.near_visible_fn ? list[i] : (uint32_t)points[list[i]].vpl;
        ism__v3_store(position, px->p);
        ism__v3_store(geometric, px->ng);
        fn(w->s.near_visible_fn ? w->s.near_visible_user : w->s.visible_user, position, geometric, numbers,
           count, visible);
        return;
    }
    for (i = 0; i < count && !w->s.no_maps; i++) {
        uint32_t v = (uint32_t)points[list[i]].vpl;
        ism__look_at(w->m, v, ism__near_axes(w, v), px->p, px->ng, &looks[i]);
    }
    for (i = 0; i < count; i++)
        visible[i] = w->s.no_maps ? 1.0f : ism__near_lit(w, &points[list[i]], px, &looks[i]);
}

/* ==== src/ism/cull.h ==== */

/* ---- cull: VPLs that no receiver of a block can see ---- */

/* Flags the VPLs that no pixel of a block can see, since all eight corners of the pixels' box lie behind the
   VPL (T56). There is a flag for each place in `order`. counts: adds the pairs that are culled, and all
   pairs. */
static void ism__cull(const ism__shade_work *w, uint32_t bx, uint32_t by, uint8_t *skip, double counts[2])
{
    const ism_maps *m = w->m;
    ism__v3 lo = ism__v3_make(1e30f, 1e30f, 1e30f), hi = ism__v3_make(-1e30f, -1e30f, -1e30f), p, n;
    uint32_t x, y, i, k;
    for (y = by; y < by + ISM__BLOCK && y < w->view->height; y++)
        for (x = bx; x < bx + ISM__BLOCK && x < w->view->width; x++)
            if (ism__receiver(w->view, (size_t)y * w->view->width + x, &p, &n)) {
                lo = ism__v3_min(lo, p);
                hi = ism__v3_max(hi, p);
            }
    for (i = 0; i < m->vpl_count; i++) {
        const ism_vpl *v = &m->vpls[w->order[i]];
        ism__v3 at = ism__v3_load(v->position),
                normal = ism__v3_load(v->exponent == 1.0f ? v->normal : v->axis);
        float most = -1e30f,
              size = ism__v3_length(ism__v3_sub(hi, lo)) + fabsf(at.x) + fabsf(at.y) + fabsf(at.z);
        for (k = 0; k < 8u; k++) {
            ism__v3 c = ism__v3_make(k & 1u ? hi.x : lo.x, k & 2u ? hi.y : lo.y, k & 4u ? hi.z : lo.z);
            float d = ism__v3_dot(normal, ism__v3_sub(c, at));
            most = d > most ? d : most;
        }
        /* Rounding must not cull a VPL that is seen: culling changes no bit of the picture. */
        skip[i] = !v->directional && most < -1e-5f * size;
        counts[0] += skip[i];
    }
    counts[1] += (double)m->vpl_count;
}

/* ==== src/ism/smooth.h ==== */

/* ---- smooth: the blur of interleaved pictures (paper 6.2) ---- */

/* Writes a pixel's mean over a window in which each class of VPLs occurs once (those at the rim half on
   either side), of neighbours on the same smooth surface. Neighbours are not chosen too strictly: where few
   are left, so are few VPLs, and spots stay. */
static void ism__smooth_pixel(const ism__shade_work *w, int x, int y, float out[3])
{
    const ism__view *view = w->view;
    int r = (int)w->interleave / 2, i, j;
    int k, width = (int)view->width, height = (int)view->height;
    float weights = 0.0f, sum[3] = { 0.0f, 0.0f, 0.0f };
    ism__v3 p, n, q, nq;
    if (!ism__receiver(view, (size_t)y * view->width + (size_t)x, &p, &n)) {
        out[0] = out[1] = out[2] = 0.0f;
        return;
    }
    for (j = -r; j <= r; j++)
        for (i = -r; i <= r; i++) {
            size_t at = (size_t)(y + j) * view->width + (size_t)(x + i);
            float weight = (i == -r || i == r ? 0.5f : 1.0f) * (j == -r || j == r ? 0.5f : 1.0f), facing, off;
            ism__v3 d;
            if (x + i < 0 || y + j < 0 || x + i >= width || y + j >= height ||
                !ism__receiver(view, at, &q, &nq))
                continue;
            d = ism__v3_sub(q, p);
            facing = ism__v3_dot(n, nq);
            off = fabsf(ism__v3_dot(n, d)) + fabsf(ism__v3_dot(nq, d));
            weight *= facing > 0.0f ? facing * facing : 0.0f;
            if (off > 0.0f) {       /* d leaves the tangent planes by this share of its length */
                off = 1.0f - off / ism__v3_length(d);
                weight *= off > 0.0f ? off : 0.0f;
            }
            for (k = 0; k < 3; k++) sum[k] += weight * w->light[3u * at + (size_t)k];
            weights += weight;
        }
    for (k = 0; k < 3; k++) out[k] = weights > 0.0f ? sum[k] / weights : 0.0f;
}

static void ism__smooth_task(void *context, size_t row)
{
    const ism__shade_work *w = (const ism__shade_work *)context;
    size_t x;
    for (x = 0; x < w->view->width; x++)
        ism__smooth_pixel(w, (int)x, (int)row, w->blurred + 3u * (row * w->view->width + x));
}

/* ==== src/ism/shade.h ==== */

/* ---- shade: all lights at all receivers (paper 6.2) ---- */

/* Adds to out, times pi, the light of all near points, also in interleaved pictures: only a class, scaled up,
   would make white specks where a pixel has few neighbours on its surface to be blurred with. */
static void ism__shade_near(const ism__shade_work *w, const ism__pixel *px, float out[3], double lost[2])
{
    const ism_near_point *points = (const ism_near_point *)w->m->near_points.data;
    const float *sphere = (const float *)w->m->near_blocks.data;
    uint32_t n = w->m->near_count, first;
    uint32_t i, k, list[ISM__CHUNK];
    float kernels[ISM__CHUNK], plain[ISM__CHUNK], visible[ISM__CHUNK], sum[3] = { 0.0f, 0.0f, 0.0f };
    float part = 1.0f / (float)(w->interleave * w->interleave);    /* what is lost counts as of one class */
    for (first = 0; first < n; first += ISM__NEAR_BLOCK, sphere += 4) {
        ism__v3 d = ism__v3_sub(ism__v3_load(sphere), px->p);
        uint32_t end = n - first < ISM__NEAR_BLOCK ? n : first + ISM__NEAR_BLOCK, used = 0;
        if (!(ism__v3_dot(d, d) < sphere[3] * sphere[3])) continue;
        for (i = first; i < end; i++) {
            float p = 0.0f, kernel = ism__near_kernel(&points[i], px, &p);
            if (!(kernel > 0.0f)) continue;
            kernels[used] = kernel;
            plain[used] = p;
            list[used++] = i;
        }
        if (used) ism__near_visibilities(w, px, list, used, visible);
        for (i = 0; i < used; i++) {
            const float *flux = points[list[i]].flux;
            float c = kernels[i] * visible[i], l = ism__luminance(flux) * visible[i] * part;
            for (k = 0; k < 3u; k++) sum[k] += c * flux[k];
            if (plain[i] > kernels[i]) lost[0] += (double)((plain[i] - kernels[i]) * l);
            lost[1] += (double)((plain[i] > kernels[i] ? plain[i] : kernels[i]) * l);
        }
    }
    for (k = 0; k < 3u; k++) out[k] += sum[k];
}

/* Writes the irradiance of one pixel by the VPLs of its class, times the number of classes, so that the mean
   over classes is the sum over all VPLs. skip: a flag for each place in `order`, or NULL. */
static void ism__shade_pixel(const ism__shade_work *w, const ism__pixel *px, uint32_t class_index,
                             const uint8_t *skip, float out[3], double lost[2])
{
    uint32_t first = w->class_first[class_index], end = w->class_first[class_index + 1u], at;
    uint32_t i, k;
    float kernels[ISM__CHUNK], plain[ISM__CHUNK], visible[ISM__CHUNK], sum[3] = { 0.0f, 0.0f, 0.0f };
    float mean = w->s.near_mode == ISM_NEAR_CLAMP_MEAN ? ism__mean_light(w, px, first, end) : 0.0f;
    uint32_t list[ISM__CHUNK];
    for (at = first; at < end; at += ISM__CHUNK) {
        uint32_t count = end - at < ISM__CHUNK ? end - at : ISM__CHUNK, used = 0;
        ism__kernels(w, px, at, count, kernels);
        for (i = 0; i < count; i++) {
            const ism_vpl *v = &w->m->vpls[w->order[at + i]];
            float k0 = kernels[i], all = k0;
            if (skip && skip[at + i]) continue;
            if (!(k0 > 0.0f) && !v->directional && v->exponent == 1.0f) continue;
            k0 = ism__kernel(w, v, &w->axes[at + i], px, k0, &all);
            if (w->s.near_mode == ISM_NEAR_CLAMP_MEAN) {
                float most = w->s.clamp * mean, l = ism__luminance(v->flux);
                if (k0 * l > most) k0 = most / l;
            }
            if (!(k0 > 0.0f)) continue;
            kernels[used] = k0;
            plain[used] = all;
            list[used++] = at + i;
        }
        ism__visibilities(w, px, list, used, visible);
        for (i = 0; i < used; i++) {
            const ism_vpl *v = &w->m->vpls[w->order[list[i]]];
            float c = kernels[i] * visible[i], l = ism__luminance(v->flux) * visible[i];
            for (k = 0; k < 3u; k++) sum[k] += c * v->flux[k];
            if (plain[i] > kernels[i]) lost[0] += (double)((plain[i] - kernels[i]) * l);
            lost[1] += (double)((plain[i] > kernels[i] ? plain[i] : kernels[i]) * l);
        }
    }
    for (k = 0; k < 3u; k++) sum[k] *= (float)(w->interleave * w->interleave);
#ifndef ISM_WITHOUT_NEAR_POINTS
    if (w->s.near_mode == ISM_NEAR_GATHER) ism__shade_near(w, px, sum, lost);
#endif
    for (k = 0; k < 3u; k++) out[k] = sum[k] * (1.0f / ISM__PI);
}

static void ism__shade_task(void *context, size_t index)
{
    const ism__shade_work *w = (const ism__shade_work *)context;
    const ism__view *view = w->view;
    uint32_t bx = (uint32_t)(index % w->blocks_x) * ISM__BLOCK,
             by = (uint32_t)(index / w->blocks_x) * ISM__BLOCK, x, y;
    const uint8_t *skip = NULL;
    double *lost = w->lost + 4u * index;
#ifndef ISM_WITHOUT_CULLING
    uint8_t flags[16384];
#endif
    lost[0] = lost[1] = lost[2] = lost[3] = 0.0;
#ifndef ISM_WITHOUT_CULLING
    if (w->s.cull) {
        ism__cull(w, bx, by, flags, lost + 2);
        skip = flags;
    }
#endif
    for (y = by; y < by + ISM__BLOCK && y < view->height; y++)
        for (x = bx; x < bx + ISM__BLOCK && x < view->width; x++) {
            size_t i = (size_t)y * view->width + x;
            float *out = w->light + 3u * i;
            ism__pixel px;
            out[0] = out[1] = out[2] = 0.0f;
            if (!ism__receiver(view, i, &px.p, &px.n)) continue;
            px.ng = ism__geometric_normal(view, i, px.n);
            ism__shade_pixel(w, &px, (y % w->interleave) * w->interleave + x % w->interleave, skip, out,
                             lost);
        }
}

/* Sorts VPLs by their classes. A class is every interleave^2-th VPL of the sequence, and so spread evenly. */
static void ism__sort_classes(const ism_maps *m, uint32_t classes, uint32_t *order, uint32_t *class_first)
{
    uint32_t c, v, k = 0;
    for (c = 0; c < classes; c++) {
        class_first[c] = k;
        for (v = c; v < m->vpl_count; v += classes) order[k++] = v;
    }
    class_first[classes] = k;
}

/* Logs that a field of a desc is out of range, and returns ISM_ERR_DESC. */
static ism_result ism__bad_field(const ism__logger *log, const char *name, double value, const char *wanted)
{
    ism__log_value(log, name, value, wanted);
    return ISM_ERR_DESC;
}

static ism_result ism__check_shading(const ism_maps *m, const ism__job *job, const ism_shading *s)
{
    const ism__logger *log = &job->log;
#ifdef ISM_WITHOUT_INTERLEAVED
    if (s->interleave > 1u)
        return ism__bad_field(log, "shading.interleave", (double)s->interleave,
                              "0 or 1 in a header that was joined without interleaved shading");
#endif
    if (s->interleave > 8u || s->interleave == 3u || (s->interleave > 4u && s->interleave < 8u))
        return ism__bad_field(log, "shading.interleave", (double)s->interleave, "0, 1, 2, 4 or 8");
    if (s->interleave > 1u && job->view.height == 1u)
        return ism__bad_field(log, "shading.interleave", (double)s->interleave,
                              "0 or 1 where receivers are a list");
    if (s->near_mode < ISM_NEAR_DEFAULT || s->near_mode >= ISM_NEAR_COUNT)
        return ism__bad_field(log, "shading.near_mode", (double)s->near_mode, "a value of ism_near");
    if (!(s->bias < 1.0f)) return ism__bad_field(log, "shading.bias", (double)s->bias, "below 1");
    if (!(s->clamp >= 0.0f) || !ism__finite(s->clamp))
        return ism__bad_field(log, "shading.clamp", (double)s->clamp, "0 or above 0");
    if (!m->chosen) return ism__too_early(log, "maps", "have no VPLs: call ism_choose before");
    if (!m->built && !s->no_maps && !s->visible_fn && m->vpl_count)
        return ism__too_early(log, "maps", "are not drawn: call ism_build before");
    return ISM_OK;
}

/* Returns settings with defaults in place of zeros. */
static ism_shading ism__resolve_shading(const ism_shading *s)
{
    ism_shading out = *s;
    if (out.near_mode == ISM_NEAR_DEFAULT) out.near_mode = ISM_NEAR_GATHER;
    if (!(out.clamp > 0.0f)) out.clamp = 1.0f;
    if (!out.interleave) out.interleave = 1u;
    out.bias = ism__bias_of(out.bias);
    return out;
}

/* Copies what shading reads of VPLs into arrays. */
static void ism__fill_fields(const ism_maps *m, const uint32_t *order, float *fields,
                             ism__orientation *axes)
{
    size_t n = m->vpl_count, i;
    for (i = 0; i < n; i++) {
        const ism_vpl *v = &m->vpls[order[i]];
        int k;
        for (k = 0; k < 3; k++) {
            fields[(size_t)k * n + i] = v->position[k];
            fields[(size_t)(k + 3) * n + i] = v->normal[k];
        }
        axes[i] = ism__vpl_axes(m, v);
    }
}

/* Writes results: irradiances, times albedo / pi if the receivers have albedos. */
static void ism__reflect(const ism__view *view, const float *light, float *out)
{
    size_t i, count = view->points->count, k;
    for (i = 0; i < count; i++)
        for (k = 0; k < 3u; k++) {
            float e = light[3u * i + k];
            if (view->points->albedos) {
                float a = ism__at(view->points->albedos, view->points->albedo_stride, i)[k];
                e = ism__finite(a) && a > 0.0f ? e * a * (1.0f / ISM__PI) : 0.0f;
            }
            out[3u * i + k] = e;
        }
}

/* Adds up what the blocks counted. */
static void ism__sum_lost(const ism__shade_work *w, size_t blocks, ism_stats *stats)
{
    double lost = 0.0, all = 0.0, culled = 0.0, pairs = 0.0;
    size_t i;
    for (i = 0; i < blocks; i++) {
        lost += w->lost[4u * i];
        all += w->lost[4u * i + 1u];
        culled += w->lost[4u * i + 2u];
        pairs += w->lost[4u * i + 3u];
    }
    stats->lost_energy = all > 0.0 ? lost / all : 0.0;
    stats->culled = pairs > 0.0 ? culled / pairs : 0.0;
}

/* Places the arrays in the memory of one call: doubles first, then those that need less alignment. */
static void ism__lay_out_shading(ism__shade_work *w, char *memory, size_t pixels, size_t blocks)
{
    const ism_maps *m = w->m;
    size_t n = m->vpl_count;
    double *lost = (double *)(void *)memory;
    ism__orientation *axes = (ism__orientation *)(void *)(lost + 4u * blocks);
    float *fields = (float *)(void *)(axes + n), *light = fields + n * ISM__FIELDS;
    uint32_t *order = (uint32_t *)(void *)(light + pixels * 3u * (w->interleave > 1u ? 2u : 1u));
    ism__sort_classes(m, w->interleave * w->interleave, order, order + n);
    ism__fill_fields(m, order, fields, axes);
    w->lost = lost;
    w->axes = axes;
    w->fields = fields;
    w->light = light;
    w->blurred = light + pixels * 3u;
    w->order = order;
    w->class_first = order + n;
}

static ism_result ism__shade(const ism_maps *m, const ism__job *job, const ism_shading *shading, float *out,
                             ism_stats *stats)
{
    const ism__view *view = &job->view;
    ism__shade_work w;
    size_t pixels = view->points->count, blocks, n = m->vpl_count;
    size_t floats, size;
    char *memory;
    int whole;
    ism_result result = ism__check_shading(m, job, shading);
    if (result != ISM_OK) return result;
    memset(&w, 0, sizeof w);
    w.m = m;
    w.view = view;
    w.s = ism__resolve_shading(shading);
    w.interleave = w.s.interleave;
    w.blocks_x = (view->width + ISM__BLOCK - 1u) / ISM__BLOCK;
    blocks = (size_t)w.blocks_x * ((view->height + ISM__BLOCK - 1u) / ISM__BLOCK);
    floats = pixels * 3u * (w.interleave > 1u ? 2u : 1u) + n * ISM__FIELDS;
    size = blocks * 4u * sizeof(double) + (n + 65u) * sizeof(uint32_t);
    if (!ism__mul_size(floats, sizeof(float), &floats) || !ism__add_size(size, floats, &size)) {
        ism__log_value(&job->log, "points.count", (double)pixels, "less: its memory does not fit a size_t");
        return ISM_ERR_LIMIT;
    }
    size += n * sizeof(ism__orientation);
    memory = (char *)ism__alloc(&m->memory, size);
    if (!memory) return ism__no_memory(&job->log);
    ism__lay_out_shading(&w, memory, pixels, blocks);
    whole = ism__run(m, &job->part, 0.0f, w.interleave > 1u ? 0.9f : 1.0f, blocks, ism__shade_task, &w);
#ifndef ISM_WITHOUT_INTERLEAVED
    if (whole && w.interleave > 1u)
        whole = ism__run(m, &job->part, 0.9f, 1.0f, view->height, ism__smooth_task, &w);
#endif
    if (!whole) {
        ism__free(&m->memory, memory);
        return ISM_ERR_CANCELLED;
    }
    ism__reflect(view, w.interleave > 1u ? w.blurred : w.light, out);
    if (stats) {
        *stats = m->stats;
        ism__sum_lost(&w, blocks, stats);
        if (stats->bytes + size > stats->peak_bytes) stats->peak_bytes = stats->bytes + size;
    }
    ism__free(&m->memory, memory);
    return ISM_OK;
}

ISM_DEF ism_result ism_shade(const ism_maps *m, const ism_points *points, const ism_shading *shading,
                             float *out, ism_stats *stats)
{
    ism__job job;
    ism_shading none;
    ism_result result;
    if (!m) return ISM_ERR_ARGUMENT;
    ism__begin_job(&m->desc.system, "ism_shade", NULL, &job);
    if (!out) return ism__is_null(&job.log, "out");
    result = ism__open_view(&job.log, points, &job.view);
    memset(&none, 0, sizeof none);
    return result == ISM_OK ? ism__shade(m, &job, shading ? shading : &none, out, stats) : result;
}

/* ==== src/ism/bounce.h ==== */

/* ---- bounce: imperfect reflective shadow maps ---- */

/* The arrays to which the source of the next bounce is written. */
typedef struct ism__bounce_out { float *positions, *normals, *fluxes; } ism__bounce_out;

/* Writes one texel of a tile as pVPL i of the next bounce. share: the part of the VPL's flux that leaves
   through the texel. */
static void ism__bounce_texel(const ism_maps *m, const ism_mesh *mesh, uint32_t v, const uint32_t texel[2],
                              float share, const ism__bounce_out *out, size_t i)
{
    size_t column = v % m->tiles, row = v / m->tiles, size = m->desc.tile_side;
    size_t at = (row * size + texel[1]) * m->side + column * size + texel[0];
    uint32_t t = ((const uint32_t *)m->hits.data)[at], k;
    const ism_vpl *vpl = &m->vpls[v];
    ism__orientation f = ism__vpl_axes(m, vpl);
    float uv[2], direction[3], length;
    ism__v3 p[3], n, d, none = ism__v3_make(0.0f, 0.0f, 0.0f);
    ism__v3_store(out->positions + 3u * i, none);
    ism__v3_store(out->normals + 3u * i, ism__v3_make(0.0f, 1.0f, 0.0f));
    ism__v3_store(out->fluxes + 3u * i, none);
    if (t == UINT32_MAX || vpl->directional) return;
    uv[0] = ((float)texel[0] + 0.5f) / (float)size;
    uv[1] = ((float)texel[1] + 0.5f) / (float)size;
    ism_map_direction(ism__projection_of(m, vpl), vpl->exponent, uv, direction);
    if (!(direction[2] > 0.0f)) return;
    ism__corners(mesh, t, p);
    n = ism__v3_cross(ism__v3_sub(p[1], p[0]), ism__v3_sub(p[2], p[0]));
    length = ism__v3_length(n);
    if (!(length > 0.0f) || !ism__finite(length)) return;
    d = ism__to_world(&f, ism__v3_load(direction));
    n = ism__v3_scale(n, (ism__v3_dot(n, d) > 0.0f ? -1.0f : 1.0f) / length);
    ism__v3_store(out->positions + 3u * i,
                  ism__v3_madd(ism__v3_load(vpl->position), d, ((const float *)m->atlas.data)[at]));
    ism__v3_store(out->normals + 3u * i, n);
    for (k = 0; k < 3u; k++)
        out->fluxes[3u * i + k] = vpl->flux[k] * share * (mesh->albedos ? mesh->albedos[3u * t + k] : 0.5f);
}

/* Returns how much of a VPL's light leaves through a cell, but for a factor: the VPL's intensity x solid
   angle at the centre of texel (x, y), which stands for the cell. All cells of COSINE and LOBE maps are
   equal. */
static float ism__cell_weight(const ism_maps *m, const ism_vpl *v, uint32_t x, uint32_t y)
{
    ism_projection projection = ism__projection_of(m, v);
    float size = (float)m->desc.tile_side, e = 0.25f / size, uv[2], d[4][3];
    int k;
    ism__v3 n;
    if (projection == ISM_PROJECTION_COSINE || projection == ISM_PROJECTION_LOBE) return 1.0f;
    for (k = 0; k < 4; k++) {       /* the corners of a small square in the map, as directions */
        uv[0] = ((float)x + 0.5f) / size + (k == 1 || k == 2 ? e : -e);
        uv[1] = ((float)y + 0.5f) / size + (k >= 2 ? e : -e);
        ism_map_direction(projection, v->exponent, uv, d[k]);
    }
    n = ism__v3_cross(ism__v3_sub(ism__v3_load(d[2]), ism__v3_load(d[0])),
                      ism__v3_sub(ism__v3_load(d[3]), ism__v3_load(d[1])));
    if (!(d[0][2] > 0.0f)) return 0.0f;
    return ism__v3_length(n) * (v->exponent == 1.0f ? d[0][2] : ism__pow(d[0][2], v->exponent));
}

/* Writes the side * side pVPLs of one VPL's tile: zeros if there is no such VPL. */
static void ism__bounce_vpl(const ism_maps *m, const ism_mesh *mesh, uint32_t v, uint32_t side,
                            const ism__bounce_out *out)
{
    size_t cells = (size_t)side * side, first = v * cells, c;
    uint32_t step = m->desc.tile_side / side, texel[2];
    float sum = 0.0f;
    if (v >= m->vpl_count) {
        memset(out->positions + 3u * first, 0, 3u * cells * sizeof(float));
        memset(out->normals + 3u * first, 0, 3u * cells * sizeof(float));
        memset(out->fluxes + 3u * first, 0, 3u * cells * sizeof(float));
        return;
    }
    for (c = 0; c < cells; c++)
        sum += ism__cell_weight(m, &m->vpls[v], (uint32_t)(c % side) * step + step / 2u,
                                (uint32_t)(c / side) * step + step / 2u);
    for (c = 0; c < cells; c++) {
        texel[0] = (uint32_t)(c % side) * step + step / 2u;
        texel[1] = (uint32_t)(c / side) * step + step / 2u;
        ism__bounce_texel(m, mesh, v, texel, ism__cell_weight(m, &m->vpls[v], texel[0], texel[1]) / sum, out,
                          first + c);
    }
}

ISM_DEF ism_result ism_bounce(const ism_maps *m, const ism_mesh *mesh, uint32_t side, float *positions,
                              float *normals, float *fluxes)
{
    uint32_t v;
    ism__bounce_out out;
    ism__job job;
    ism_result result;
    if (!m) return ISM_ERR_ARGUMENT;
    ism__begin_job(&m->desc.system, "ism_bounce", NULL, &job);
    if (!mesh || !positions || !normals || !fluxes)
        return ism__is_null(&job.log, !mesh        ? "mesh"
                                      : !positions ? "positions"
                                      : !normals   ? "normals"
                                                   : "fluxes");
    if (!side || (side & (side - 1u)) || side > m->desc.tile_side) {
        ism__log_value(&job.log, "side", (double)side, "a power of two, desc.tile_side at most");
        return ISM_ERR_ARGUMENT;
    }
    if (!m->desc.keep_hits) {
        ism__log_text(&job.log, "maps", "have no hits: they were made without desc.keep_hits");
        return ISM_ERR_MISMATCH;
    }
    if (!m->built || !m->hits.data)
        return ism__too_early(&job.log, "maps", "are not drawn: call ism_build before");
    result = ism__check_mesh(&job.log, mesh);
    if (result == ISM_OK && m->triangles && ism__mesh_triangles(mesh) != m->triangles) {
        ism__log_value(&job.log, "the mesh's count of triangles", (double)ism__mesh_triangles(mesh),
                       "that of the last ism_build");
        result = ISM_ERR_MISMATCH;
    }
    if (result == ISM_OK) result = ism__check_indices(&job.log, mesh);
    if (result != ISM_OK) return result;
    out.positions = positions;
    out.normals = normals;
    out.fluxes = fluxes;
    for (v = 0; v < m->desc.vpl_count; v++) ism__bounce_vpl(m, mesh, v, side, &out);
    return ISM_OK;
}

/* ==== src/ism/sources.h ==== */

/* ---- sources: points on lamps, directions of a sky, points as VPLs ---- */

/* Writes the power that leaves each triangle, over pi; 0 if the triangle's radiance cannot be used. */
static void ism__weigh_emitters(const ism_mesh *mesh, const float *radiances, size_t triangles,
                                float *weights)
{
    size_t t;
    for (t = 0; t < triangles; t++) {
        ism__v3 p[3];
        ism__corners(mesh, t, p);
        weights[t] = ism__flux_ok(radiances + 3u * t)
                   ? ism__luminance(radiances + 3u * t) * 0.5f *
                     ism__v3_length(ism__v3_cross(ism__v3_sub(p[1], p[0]), ism__v3_sub(p[2], p[0])))
                   : 0.0f;
    }
}

/* Draws count points on triangles in proportion to their power: point i at (i + 0.5) / count of the sum of
   all, and within its triangle by the golden ratio. */
static void ism__place_emitters(const ism_mesh *mesh, const float *radiances, const ism__cdf *cdf,
                                uint32_t count, uint32_t seed, float *positions, float *normals,
                                float *fluxes)
{
    const uint32_t key = ism__hash_combine(seed, 21u);
    uint32_t i, k;
    for (i = 0; i < count; i++) {
        ism__cdf_sample s = ism__cdf_sample_at(cdf, (float)(((double)i + 0.5) / (double)count));
        ism__v3 p[3], n;
        float b1, b2, area;
        ism__triangle_map(ism__to_unit(key + i * 3242174889u),
                          ism__to_unit(ism__hash32(key) + i * 2447445413u), &b1, &b2);
        ism__corners(mesh, s.index, p);
        p[1] = ism__v3_sub(p[1], p[0]);
        p[2] = ism__v3_sub(p[2], p[0]);
        n = ism__v3_cross(p[1], p[2]);
        area = 0.5f * ism__v3_length(n);
        ism__v3_store(positions + 3u * (size_t)i, ism__v3_madd(ism__v3_madd(p[0], p[1], b1), p[2], b2));
        ism__v3_store(normals + 3u * (size_t)i, ism__v3_normalize(n));
        for (k = 0; k < 3u; k++)
            fluxes[3u * (size_t)i + k] =
                ISM__PI * radiances[3u * (size_t)s.index + k] * area / ((float)count * s.probability);
    }
}

ISM_DEF ism_result ism_emitter_points(const ism_mesh *mesh, const float *radiances, uint32_t count,
                                      uint32_t seed, const ism_system *system, float *positions,
                                      float *normals, float *fluxes)
{
    ism__allocator memory;
    ism__cdf cdf;
    size_t triangles = ism__mesh_triangles(mesh);
    float *weights;
    double *sums;
    int shines;
    ism_system zero = { { NULL, NULL, NULL }, NULL, NULL, NULL, NULL };
    ism__job job;
    ism_result result;
    if (system) zero = *system;
    ism__begin_job(&zero, "ism_emitter_points", NULL, &job);
    if (!mesh || !radiances || !positions || !normals || !fluxes)
        return ism__is_null(&job.log, !mesh        ? "mesh"
                                      : !radiances ? "radiances"
                                      : !positions ? "positions"
                                      : !normals   ? "normals"
                                                   : "fluxes");
    if (!count) {
        ism__log_value(&job.log, "count", 0.0, "above 0");
        return ISM_ERR_ARGUMENT;
    }
    if (!ism__allocator_valid(zero.allocator.alloc_fn, zero.allocator.free_fn)) {
        ism__log_text(&job.log, "system.allocator", "has one function of two");
        return ISM_ERR_DESC;
    }
    result = ism__check_mesh(&job.log, mesh);
    if (result == ISM_OK) result = ism__check_indices(&job.log, mesh);
    if (result != ISM_OK) return result;
    if (!triangles || triangles >= 1u << 31) {
        ism__log_value(&job.log, "the mesh's count of triangles", (double)triangles, "1..2^31 - 1");
        return triangles ? ISM_ERR_LIMIT : ISM_ERR_ARGUMENT;
    }
    memory = ism__allocator_make(zero.allocator.alloc_fn, zero.allocator.free_fn, zero.allocator.user);
    weights = (float *)ism__alloc_array(&memory, triangles, sizeof *weights);
    sums = (double *)ism__alloc_array(&memory, triangles + 1u, sizeof *sums);
    if (!weights || !sums) {
        ism__free(&memory, sums);
        ism__free(&memory, weights);
        return ism__no_memory(&job.log);
    }
    ism__weigh_emitters(mesh, radiances, triangles, weights);
    ism__cdf_build(&cdf, sums, weights, (uint32_t)triangles, 1.0);
    shines = ism__cdf_total(&cdf) > 0.0;
    if (shines) ism__place_emitters(mesh, radiances, &cdf, count, seed, positions, normals, fluxes);
    ism__free(&memory, sums);
    ism__free(&memory, weights);
    if (shines) return ISM_OK;
    ism__log_text(&job.log, "radiances", "are all 0: no triangle emits");
    return ISM_ERR_INPUT;
}

ISM_DEF ism_result ism_sky_directions(const float *texels, uint32_t width, uint32_t height, float rotation,
                                      float *directions, float *fluxes, uint64_t *bad_texels)
{
    uint32_t x, y, k;
    uint64_t bad = 0;
    double turns = (double)rotation * 0.15915494309189535;
    float half, unused;
    if (!texels || !width || !height || !directions || !fluxes || !ism__finite(rotation))
        return ISM_ERR_ARGUMENT;
    if (fabs(turns) < 1e15) rotation = (float)((double)rotation - 6.283185307179586 * (double)(int64_t)turns);
    else rotation = 0.0f;                        /* neighbouring floats are more than a turn apart there */
    ism__sincos(0.5f * ISM__PI / (float)height, &half, &unused);
    for (y = 0; y < height; y++) {
        /* Angles are taken from the nearer pole, where they are exact. Solid angles are a product: the
           difference of cosines there would have no right digit. */
        uint32_t from = y < height / 2u ? y : height - 1u - y;
        float theta = ISM__PI * ((float)from + 0.5f) / (float)height, st, ct, solid;
        ism__sincos(theta, &st, &ct);
        if (from != y) ct = -ct;
        solid = st * half * 4.0f * ISM__PI / (float)width;
        for (x = 0; x < width; x++) {
            size_t i = 3u * ((size_t)y * width + x);
            float phi = 2.0f * ISM__PI * (((float)x + 0.5f) / (float)width - 0.5f) - rotation, s, c;
            int wrong = 0;
            ism__sincos(phi, &s, &c);
            directions[i] = st * c;
            directions[i + 1u] = ct;
            directions[i + 2u] = st * s;
            for (k = 0; k < 3u; k++) {
                float value = texels[i + k];
                int good = ism__finite(value) && value >= 0.0f;
                wrong |= !good;
                fluxes[i + k] = good ? value * solid : 0.0f;
            }
            bad += (uint64_t)wrong;
        }
    }
    if (bad_texels) *bad_texels = bad;
    return ISM_OK;
}

/* Writes point i of a source as a VPL. What a point without flux has of vectors is not read. */
static void ism__point_vpl(const ism_source *s, size_t source, size_t i, ism_vpl *v)
{
    const float *flux = ism__at(s->fluxes, s->flux_stride, i);
    ism__v3 p = ism__v3_make(0.0f, 0.0f, 0.0f), n = ism__v3_make(0.0f, 1.0f, 0.0f);
    memset(v, 0, sizeof *v);
    memcpy(v->flux, flux, sizeof v->flux);
    v->source = (uint32_t)source;
    v->texel = (uint32_t)i;
    v->directional = s->kind == ISM_SOURCE_DIRECTIONS;
    if (!ism__flux_ok(flux) || ism__luminance(flux) > 0.0f) {
        p = ism__v3_load(ism__at(s->positions, s->position_stride, i));
        n = v->directional ? ism__v3_scale(p, -1.0f)
                           : ism__v3_load(ism__at(s->normals, s->normal_stride, i));
    }
    ism__v3_store(v->position, p);
    ism__v3_store(v->normal, n);
    ism__v3_store(v->axis, n);
    v->exponent = 1.0f;
    if (v->directional) return;
    if (s->lobes && ism__luminance(flux) > 0.0f) {
        memcpy(v->axis, ism__lobe(s, i), sizeof v->axis);
        v->exponent = ism__lobe(s, i)[3];
    }
    if (s->areas) v->area = *ism__at(s->areas, s->area_stride ? s->area_stride : 4u, i);
    if (!ism__in(v->area, 0.0f, ISM__MAX_FLOAT)) v->area = 0.0f;
}

ISM_DEF ism_result ism_set_sources(ism_maps *m, const ism_source *sources, size_t source_count)
{
    ism__job job;
    ism_frame frame;
    ism_vpl v;
    size_t count = 0, doubles;
    size_t s, i, n = 0;
    ism_result result;
    if (!m) return ISM_ERR_ARGUMENT;
    memset(&frame, 0, sizeof frame);
    frame.sources = sources;
    frame.source_count = source_count;
    ism__begin_job(&m->desc.system, "ism_set_sources", &frame, &job);
    result = ism__check_sources(&job.log, &frame, &count, &doubles);
    if (result != ISM_OK) return result;
    if (count > m->desc.vpl_count) {
        ism__log_value(&job.log, "the sources' count of points", (double)count, "desc.vpl_count at most");
        return ISM_ERR_LIMIT;
    }
    for (s = 0; s < source_count; s++)
        for (i = 0; i < (size_t)sources[s].width * sources[s].height; i++, n++) {
            ism__point_vpl(&sources[s], s, i, &v);
            if ((result = ism__check_vpl(&job.log, &v, n)) != ISM_OK) return result;
        }
    for (s = n = 0; s < source_count; s++)
        for (i = 0; i < (size_t)sources[s].width * sources[s].height; i++)
            ism__point_vpl(&sources[s], s, i, &m->vpls[n++]);
    m->vpl_count = (uint32_t)count;
    m->stats.jumped = 0;
    m->built = 0;
    return ism__finish_vpls(m, &job.part, 0.0f, 1.0f);
}

/* ==== src/ism/life.h ==== */

/* ---- life: create, free, a frame in one call ---- */

ISM_DEF const char *ism_result_text(ism_result result)
{
    static const char *const texts[] = {
#define ISM__TEXT(name, text) text,
        ISM_RESULTS(ISM__TEXT)
#undef ISM__TEXT
    };
    return (int)result >= 0 && (int)result < (int)ISM_RESULT_COUNT ? texts[result] : "unknown result";
}

/* A field of ism_desc and the range in which it must lie, else the call returns ISM_ERR_DESC. Zero always
   passes. */
typedef struct ism__range { const char *name; double value, least, most; const char *wanted; } ism__range;

static int ism__power_of_two(uint32_t x) { return (x & (x - 1u)) == 0; }

static ism_result ism__check_desc(const ism__logger *log, const ism_desc *d)
{
    double side = d->tile_side ? (double)d->tile_side : 64.0;
    const ism__range ranges[] = {
        { "desc.vpl_count", (double)d->vpl_count, 1, 16384, "0 or 1..16384" },
        { "desc.surfel_count", (double)d->surfel_count, 8, 65536, "0 or 8..65536" },
        { "desc.tile_side", ism__power_of_two(d->tile_side) ? side : -1, 8, 256,
          "0 or a power of two, 8..256" },
        { "desc.importance", (double)d->importance, 0, ISM_IMPORTANCE_COUNT - 1,
          "a value of ism_importance" },
#ifdef ISM_WITHOUT_PAIR
        { "desc.spread", (double)d->spread, 0, ISM_SPREAD_VIEW_8,
          "below ISM_SPREAD_PAIR in a header that was joined without pair" },
#else
        { "desc.spread", (double)d->spread, 0, ISM_SPREAD_COUNT - 1, "a value of ism_spread" },
#endif
        { "desc.projection", (double)d->projection, 0, ISM_PROJECTION_COUNT - 1,
          "a value of ism_projection" },
        { "desc.view_grid_side", (double)d->view_grid_side, 1, 16, "0 or 1..16" },
        { "desc.blur_radius", (double)d->blur_radius, -2147483648.0, 16, "16 at most" },
        { "desc.lazy_frames", (double)d->lazy_frames, 1, 64, "0 or 1..64" },
        { "desc.flux_share", (double)d->flux_share, 0, 1, "0..1" },
        { "desc.area_share", (double)d->area_share, 0, 1, "0..1" },
        { "desc.splat_scale", (double)d->splat_scale, 0, 16, "0..16" },
#ifdef ISM_WITHOUT_NEAR_POINTS
        { "desc.near_point_count", (double)d->near_point_count, -2147483648.0, 0,
          "0 or less in a header that was joined without near points" },
#else
        { "desc.near_point_count", (double)d->near_point_count, -2147483648.0, 64, "64 at most" },
#endif
#ifdef ISM_WITHOUT_WINDOWS
        { "desc.window_rim", (double)d->window_rim, -2147483648.0, 0,
          "0 or less in a header that was joined without windows" }
#else
        { "desc.window_rim", d->window_rim < 0 ? 0.0 : (double)d->window_rim, 2, 0.5 * side,
          "negative, 0 or 2..tile_side / 2" }
#endif
    };
    size_t i;
    for (i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        const ism__range *r = &ranges[i];
        if (r->value >= r->least && r->value <= r->most) continue;
        if (r->value >= 0.0 && r->value <= 0.0) continue;
        return ism__bad_field(log, r->name, i == 2u ? (double)d->tile_side : r->value, r->wanted);
    }
    if (ism__allocator_valid(d->system.allocator.alloc_fn, d->system.allocator.free_fn)) return ISM_OK;
    ism__log_text(log, "desc.system.allocator", "has one function of two");
    return ISM_ERR_DESC;
}

/* Puts defaults in place of zeros, and 0 in place of negative numbers, which mean none. */
static void ism__resolve(ism_desc *d)
{
    if (!d->vpl_count) d->vpl_count = 1024u;
    if (!d->surfel_count) d->surfel_count = 8192u;
    if (!d->tile_side) d->tile_side = 64u;
    if (d->importance == ISM_IMPORTANCE_DEFAULT) d->importance = ISM_IMPORTANCE_GUIDED;
#ifdef ISM_WITHOUT_PAIR
    if (d->spread == ISM_SPREAD_DEFAULT) d->spread = ISM_SPREAD_VIEW_8;
#else
    if (d->spread == ISM_SPREAD_DEFAULT) d->spread = ISM_SPREAD_PAIR;
#endif
    if (d->projection == ISM_PROJECTION_DEFAULT) d->projection = ISM_PROJECTION_COSINE;
    if (!d->view_grid_side) d->view_grid_side = 4u;
    if (!d->lazy_frames) d->lazy_frames = 8u;
#ifndef ISM_WITHOUT_NEAR_POINTS
    if (!d->near_point_count) d->near_point_count = 16;
#endif
#ifndef ISM_WITHOUT_WINDOWS
    if (!d->window_rim) d->window_rim = d->tile_side >= 16u ? (int32_t)(d->tile_side / 8u) : 2;
#endif
    if (d->near_point_count < 0) d->near_point_count = 0;
    if (d->window_rim < 0) d->window_rim = 0;
    if (!(d->flux_share > 0.0f)) d->flux_share = 0.1f;
    if (!(d->area_share > 0.0f)) d->area_share = 0.2f;
    if (!(d->splat_scale > 0.0f)) d->splat_scale = 0.8f;
}

ISM_DEF ism_result ism_create(const ism_desc *desc, ism_maps **out)
{
    ism__allocator memory;
    ism_desc d;
    ism_maps *m;
    ism__tile tile;
    ism_vpl none;
    ism__job job;
    size_t texels;
    ism_result result;
    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    ism__begin_job(&d.system, "ism_create", NULL, &job);
    if (!out) return ism__is_null(&job.log, "out");
    result = ism__check_desc(&job.log, &d);
    if (result != ISM_OK) return result;
    ism__resolve(&d);
    memory =
        ism__allocator_make(d.system.allocator.alloc_fn, d.system.allocator.free_fn, d.system.allocator.user);
    m = (ism_maps *)ism__alloc(&memory, sizeof *m);
    if (!m) return ism__no_memory(&job.log);
    memset(m, 0, sizeof *m);
    m->desc = d;
    m->memory = memory;
    m->stats.bytes = m->stats.peak_bytes = sizeof *m + d.vpl_count * sizeof *m->vpls;
    for (m->tiles = 1; m->tiles * m->tiles < d.vpl_count; m->tiles++) {}
    m->side = m->tiles * d.tile_side;
    m->blank_from = m->tiles * m->tiles;
    texels = (size_t)d.tile_side * d.tile_side;
    m->vpls = (ism_vpl *)ism__alloc_array(&memory, d.vpl_count, sizeof *m->vpls);
    if (!m->vpls || !ism__grow(m, &m->previous, d.vpl_count, sizeof *m->vpls) ||
        !ism__grow(m, &m->directions, texels, 3u * sizeof(float))) {
        ism_free(m);
        return ism__no_memory(&job.log);
    }
    memset(&none, 0, sizeof none);
    memset(&tile, 0, sizeof tile);
    tile.vpl = &none;
    tile.size = d.tile_side;
    tile.projection = d.projection == ISM_PROJECTION_LOBE ? ISM_PROJECTION_COSINE : d.projection;
    ism__tile_directions(&tile, (float *)m->directions.data);
    *out = m;
    return ISM_OK;
}

ISM_DEF void ism_free(ism_maps *m)
{
    ism__allocator memory;
    if (!m) return;
    memory = m->memory;
    ism__release(m, &m->previous);
    ism__release(m, &m->atlas);
    ism__release(m, &m->hits);
    ism__release(m, &m->surfels);
    ism__release(m, &m->counts);
    ism__release(m, &m->directions);
    ism__release(m, &m->scratch);
    ism__release(m, &m->sums);
    ism__release(m, &m->clusters);
    ism__release(m, &m->shares);
    ism__release(m, &m->weights);
    ism__release(m, &m->sources);
    ism__release(m, &m->importance);
    ism__release(m, &m->blurred);
    ism__release(m, &m->cdf);
    ism__release(m, &m->pixels);
    ism__release(m, &m->near_points);
    ism__release(m, &m->near_blocks);
    ism__release(m, &m->near_drawn);
    ism__release(m, &m->near_keys);
    ism__release(m, &m->windows);
    ism__free(&memory, m->vpls);
    ism__free(&memory, m);
}

ISM_DEF void ism_get_info(const ism_maps *m, ism_info *out)
{
    if (!m || !out) return;
    out->vpl_count = m->vpl_count;
    out->near_point_count = m->near_count;
    out->surfel_count = m->desc.surfel_count;
    out->tile_side = m->desc.tile_side;
    out->lazy_frames = m->desc.lazy_frames;
    memcpy(out->center, m->center, sizeof m->center);
    out->radius = m->radius;
    out->stats = m->stats;
}

ISM_DEF ism_result ism_render(ism_maps *m, const ism_frame *frame, const ism_shading *shading, float *out,
                              ism_stats *stats)
{
    ism__job job, part;
    ism_shading none;
    ism_result result = ism__open_frame(m, frame, "ism_render", &job);
    if (result == ISM_OK && !out) result = ism__is_null(&job.log, "out");
    if (result != ISM_OK) return result;
    memset(&none, 0, sizeof none);
    if (!shading) shading = &none;
    part = job;
    part.part = ism__part_of(&job.part, 0.0f, 0.2f);
    result = ism__choose(m, &part);
    part.part = ism__part_of(&job.part, 0.2f, 0.5f);
    if (result == ISM_OK && !shading->no_maps && !shading->visible_fn) result = ism__build(m, &part);
    part.part = ism__part_of(&job.part, 0.5f, 1.0f);
    return result == ISM_OK ? ism__shade(m, &part, shading, out, stats) : result;
}

/* ==== src/shared/fp_end.h ==== */

/* unit fp_end: the user's options again. clang and MSVC keep contraction off to the end of the file. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__)
#pragma GCC pop_options
#endif

/* ==== src/ism/end.h ==== */

#endif /* ISM_IMPLEMENTATION */

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
