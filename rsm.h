/* rsm.h - v1.0.0 - reflective shadow maps: one bounce of light from a shadow map - MIT-0 OR Unlicense

   What it does

   A shadow map that stores position, normal and reflected flux knows every surface from which light can come
   after one bounce. This header fills such maps from your renderer's buffers or from triangles, takes their
   texels as small lights, and gathers the light of these at points: at pixels, with or without interpolation,
   or at vertices. After Dachsbacher and Stamminger, "Reflective Shadow Maps", I3D 2005. Flux, weights and
   units are exact where the paper's are not; docs/rsm.md says where.

   What it does not do

   - Nothing stands in the way of bounced light by itself: surfaces behind others are lit too, as in the
     paper. What a point sees of each light is asked of a function (visible_fn), such as ism.h and csm.h have,
     or of yours; the share of all light that reaches a point (ambient occlusion) is taken as input, too.
   - Light bounces once. The header renders no pictures, starts no threads and opens no files.

   Quick start

   In exactly one source file write the define; everywhere else include the header alone.

       #define RSM_IMPLEMENTATION
       #include "rsm.h"
       #include <stdio.h>

       int main(void)
       {
           static const float corners[] = { -1, 0, -1,  1, 0, -1,  1, 0, 1,  -1, 0, 1 };   // a floor
           static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2 };
           const float above[3] = { 0, 1, 0 }, down[3] = { 0, -1, 0 };
           static rsm_desc desc;                            // static: all zero, the defaults
           static rsm_mesh mesh;
           static rsm_points points;
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
           if (rsm_gather((const rsm_map *const *)&map, 1, NULL, &points, e, NULL) != RSM_OK) return 1;
           printf("irradiance from the floor: %.3f, exact 0.277\n", (double)e[0]);
           rsm_map_free(map);
           return !(e[0] > 0.27f && e[0] < 0.285f);
       }

   Conventions

   Space is right-handed. Matrices are column-major float[16]. Distances are in your units, angles in radians,
   irradiance in W/m^2, intensity in W/sr, flux in W. Colours are linear, three floats r, g, b. A vector that
   is called unit may have a length from 0.97 to 1.03 and is used as it is; any other length is an error, and
   the log names the element.

     map        what one light sees: 1 face, 5 faces of a cube (of a patch), or 6 (of a point)
     texel      one pixel of a face. Texels lie row by row, row 0 at the bottom (v = 0)
     light      a pixel light is a texel that shines: flux leaves the texel about its normal as from a diffuse
                surface, with the intensity flux / pi x cosine
     receiver   a point that is lit by pixel lights. Results are irradiances: multiply by albedo / pi
     pattern    which texels a receiver takes as samples: those about its own projection into the map, or
                texels chosen by flux

   How it works

     rsm_map_create -> rsm_fill (your buffers) or rsm_rasterize (triangles), each face -> rsm_finish
       -> rsm_direct         direct light of receivers by the same map
       -> rsm_gather         bounced light of any receivers
       -> rsm_interpolate    the same for a picture: light at a coarse grid of pixels, mostly interpolated
       -> rsm_pixel_lights, rsm_cluster -> rsm_gather_list: a list of lights for all receivers

   rsm_redraw does the first line for the next frame, and keeps the map if light and meshes are what they
   were. gifilter.h makes pictures from few samples smooth, over frames and over neighbours.

   A map takes 56 bytes a texel (48 of them are rsm_texel), a list 48 bytes a light, a gather 60 bytes a light
   in scratch (88 with materials), interpolation 11 bytes a pixel. The knobs, and what each trades:

     sample_count
                fewer: faster, with bands (lists and patterns that are not turned) or noise (noise,
                interleave), and bright dots where surfaces meet. 0, the default, takes every texel
     pattern    FLUX is fastest; MIXED has the least error where light near a corner matters
     offset     more: corners have fewer bright dots, and are darker than they should be
     near_limit less: the same, by a bound on each light; the light that is lost is counted
     near_field more: near texels are surfaces, not points, so that corners have no dots; nothing to a third
                more time
     side       fewer texels: blurred lights, and more dots in corners

   From the paper to the code

     section 3.1  what a texel stores                      rsm_texel, rsm_map_texels            T34 T35
     section 3.1  the intensity of a texel (figure 2)      rsm_gather_list                      T29
     eq. (1)      irradiance from one texel, over pi here  rsm_gather, rsm_gather_list          T25 T28 T40
     section 3.2  flux through a texel, times albedo       rsm_rasterize, rsm_fill, rsm_finish  T30 T31 T33
     section 3.2  lights move below their surface          rsm_gather_desc (offset)             T38
     eq. (2)      the sum over texels                      rsm_gather                           T32 T42 T44
     section 3.3  bounced light without shadows, or with    rsm_gather_desc (visible_fn)         -
     section 3.3  a receiver's projection into the map     rsm_map_project                      T34
     eq. (3)      samples about the projection             rsm_pattern_build, rsm_pattern       T26 T27 T36
     section 3.3  samples weighted by xi^2, normalised     rsm_gather_desc (paper_weights)      T26
     section 3.3  a Poisson pattern                        rsm_pattern (POISSON)                T25 T26 T36
     figure 4     the pattern and its weights              rsm_pattern_build                    T26
     section 4    interpolation where samples look alike   rsm_interpolate                      T39
     figure 5     which pixels are not interpolated        rsm_interpolate                      T39
     section 4    direct light by the same map             rsm_direct                           T29
     section 5    deferred shading, in passes              in gl_backend/gl_rsm.h               -
     table 1      how many samples are taken (figure 7)    rsm_gather_desc (sample_count)       T25 T27
     section 6    textures are averaged over a texel       rsm_mesh (tap_side)                  -
     figure 6     ambient occlusion as a factor            rsm_points (open)                    -
     section 7    light gathered at vertices               rsm_gather                           T25
     section 7    lamps all round, and area lights         rsm_light_kind                       T30 T37
     section 7    reflectors that are not diffuse          rsm_material                         -

   The last column names the rows of docs/conformance.md that test a line; a - says that there is none. These
   lines are held to sums by hand in tests/rsm (the_callback_gets_the_taps_of_a_texel,
   every_pattern_sums_its_samples).

   docs/rsm.md says where the code departs from the paper, and why.

   Configuration

     RSM_IMPLEMENTATION   in one source file: compiles the code
     RSM_STATIC           beside it: a private copy for this file, all functions static
     RSM_DEF              everywhere: your own linkage instead
     RSM_NO_SIMD          with the implementation: portable code only (results are the same to the bit)
     RSM_FILE             with the implementation: this file's name, if it is not "rsm.h". The file includes
                          itself for AVX2 and AVX-512; where it cannot, it does without them

   Memory, errors, threads, determinism

   All memory comes from the allocator of the rsm_system, called from the thread that called us. Every
   function that can fail returns an rsm_result. If the result is not RSM_OK, outputs are untouched (unless a
   contract says otherwise), nothing leaks, and the system's log is told which field or element is wrong.
   There are no globals: any number of threads may use finished maps at once; a map that is being filled
   belongs to one thread at a time. The same input gives the same bytes on every compiler, processor, byte
   order and thread count (not with x87 arithmetic, nor with clang's -ffast-math).

   Cost: docs/rsm.md and build/bench rsm_gather.   History: CHANGELOG.md.   Licence: end of this file. */
#ifndef RSM_H
#define RSM_H

#define RSM_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "rsm.h needs C99 or C++11"
#endif
#if defined(RSM_STATIC) && !defined(RSM_IMPLEMENTATION)
#error "RSM_STATIC makes all functions private: RSM_IMPLEMENTATION belongs into the same file"
#endif

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

/* ==== src/rsm/api_page_one.h ==== */

/* ---- page one: bounced light from triangles ---- */

#define RSM_RESULTS(X)                                                                                       \
    X(RSM_OK, "ok")                                                                                          \
    X(RSM_ERR_ARGUMENT, "a pointer is NULL, or a count or stride is out of range")                           \
    X(RSM_ERR_DESC, "a field of a desc is out of range")                                                     \
    X(RSM_ERR_INPUT, "the data cannot be used")                                                              \
    X(RSM_ERR_ALLOC, "the allocator returned no memory")                                                     \
    X(RSM_ERR_MEMORY, "the caller's memory is too small or misaligned")                                      \
    X(RSM_ERR_LIMIT, "a size overflows or passes a limit")                                                   \
    X(RSM_ERR_CANCELLED, "cancelled by the progress callback")                                               \
    X(RSM_ERR_ORDER, "this call comes too early, too late or twice")                                         \
    X(RSM_ERR_FORMAT, "not a file of this kind, or a damaged one")                                           \
    X(RSM_ERR_VERSION, "a file of an unknown version")                                                       \
    X(RSM_ERR_MISMATCH, "what was given does not belong together")

typedef enum rsm_result {
#define RSM__ENUM(name, text) name,
    RSM_RESULTS(RSM__ENUM)
#undef RSM__ENUM
    RSM_RESULT_COUNT
} rsm_result;

typedef struct rsm_map rsm_map;     /* a reflective shadow map: what one light sees */
struct rsm_desc;                    /* the light, and how fine its map is */
struct rsm_mesh;                    /* triangles */
struct rsm_points;                  /* receivers: the points to be lit */
struct rsm_gather_desc;             /* which texels light the receivers, and how: see "bounced light" below */
struct rsm_stats;                   /* what rsm_finish counts: see "maps from your renderer" below */
struct rsm_gather_stats;            /* what rsm_gather counts: see "bounced light" below */

RSM_DEF rsm_result rsm_map_create(const struct rsm_desc *desc, rsm_map **out);
/* Makes an empty map for one light. Give it back by rsm_map_free.
   out      written on RSM_OK only
   Errors   RSM_ERR_ARGUMENT: desc or out is NULL. RSM_ERR_DESC: a field of desc is out of range.
            RSM_ERR_LIMIT: size_t cannot count the bytes. RSM_ERR_ALLOC: there is no memory. */

RSM_DEF rsm_result rsm_rasterize(rsm_map *map, const struct rsm_mesh *meshes, size_t mesh_count);
/* Draws triangles into all faces of the map, in place of what the map had. Both sides of a triangle are seen,
   and its normal is turned towards the light. Triangles without area or with a vertex that is not finite are
   left out and counted.
   Errors   RSM_ERR_ARGUMENT: map, meshes or positions are NULL, both kinds of indices are given, a count is
            no multiple of 3, or vertex_stride is out of range. RSM_ERR_INPUT: an index is not below
            vertex_count, or tap_side, an albedo or transform is out of range. RSM_ERR_LIMIT: there are
            2^32 - 1 triangles or more. RSM_ERR_ORDER: the map is finished. After these the map is as it was;
            after RSM_ERR_ALLOC (there is no memory) and RSM_ERR_CANCELLED it is empty
   Cost     scratch of 8 bytes a triangle and 4 a texel of one face */

RSM_DEF rsm_result rsm_finish(rsm_map *map, struct rsm_stats *stats);
/* Ends the filling of a map, which any number of threads may use from then on. stats may be NULL.
   Errors   RSM_ERR_ARGUMENT: map is NULL. RSM_ERR_ORDER: the map is finished already. */

RSM_DEF rsm_result rsm_gather(const rsm_map *const *maps, size_t map_count,
                              const struct rsm_gather_desc *desc,
                              const struct rsm_points *points, float *irradiance,
                              struct rsm_gather_stats *stats);
/* Writes the irradiance that reaches each receiver from the texels of all maps.
   desc     NULL = all defaults
   irradiance   receives 3 floats for each of points->count points, W/m^2; times albedo / pi that is radiance
   stats    receives what was counted; may be NULL. A gather that counts takes a fifth longer if desc->clamp
            or desc->near_limit is set
   Errors   RSM_ERR_ARGUMENT: a pointer is NULL, map_count is 0, or a stride is out of range. RSM_ERR_DESC: a
            field of desc is out of range. RSM_ERR_INPUT: a normal is not unit, or an index, a material or
            noise is out of range. RSM_ERR_LIMIT: size_t cannot count the points' bytes. RSM_ERR_ORDER: a map
            is not finished. RSM_ERR_ALLOC: there is no memory. After these nothing is written; after
            RSM_ERR_CANCELLED some points may have been written
   Cost     receivers x maps x samples, about 1 ns each (FLUX), 20 ns (patterns about the receiver) */

RSM_DEF void rsm_map_free(rsm_map *map);
/* Gives back a map and its memory. NULL is allowed, and so are maps of rsm_map_init, whose memory stays
   yours. */

/* ---- results; memory, threads, progress, log: the caller's ---- */

RSM_DEF const char *rsm_result_text(rsm_result result);
/* Returns a constant string that says what a result means; "unknown result" for a number that is none. */

typedef struct rsm_allocator {      /* all zero: malloc and free; else both functions */
    void *(*alloc_fn)(size_t bytes, void *user);    /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} rsm_allocator;

typedef void (*rsm_task)(void *context, size_t index);

typedef struct rsm_system {         /* all zero: malloc and free, this thread alone, no progress, no log */
    rsm_allocator allocator;        /* called from the thread that called us */
    void (*parallel_for)(void *user, size_t count, rsm_task task, void *context);
    /* Must call task(context, i) once for each i < count, in any order and on any threads, and return when
       all are done. What is computed does not depend on the threads. */
    int (*progress)(void *user, float fraction);
    /* Called from the thread that called us, fraction 0..1 never falling within a call; not 0 cancels. */
    void (*log)(void *user, const char *message);
    /* Called at most once by a call that fails, from the thread that called us, before it returns: one line
       without a line end that names the function, the field or element, its value and its range. */
    void *user;                     /* given to parallel_for, progress and log */
} rsm_system;

/* ---- structs of page one ---- */

typedef enum rsm_light_kind {       /* what a light is, and with it the shape of its map */
    RSM_LIGHT_DEFAULT,              /* = RSM_LIGHT_SUN */
    RSM_LIGHT_SUN,                  /* parallel light; the map is a square of side 2 radius about position */
    RSM_LIGHT_SPOT,                 /* even intensity in a round cone with a hard rim; above 1 radian the map
                                       is a cube */
    RSM_LIGHT_SQUARE_SPOT,          /* even intensity in a square pyramid, which is the whole map; up to 1
                                       radian */
    RSM_LIGHT_POINT,                /* even intensity all round; the map is a cube */
    RSM_LIGHT_PATCH,                /* a small piece of a diffuse emitter, whose intensity falls with the
                                       cosine; the map is half a cube. Several patches make an area light */
    RSM_LIGHT_COUNT
} rsm_light_kind;

typedef struct rsm_light {          /* of its fields near_depth and far_depth alone have defaults for 0 */
    rsm_light_kind kind;
    float position[3];              /* of the lamp, up to 1e9; of a sun the centre of what its map covers */
    float direction[3];             /* any length but 0. Sun: towards the sun; spots: out of the lamp; patch:
                                       its normal; points need none */
    float up[3];                    /* which way v grows in the map, any length; 0 0 0 = +Y, or +Z if the
                                       direction is near +Y */
    float value[3];                 /* r, g, b, 0..1e12. Sun: irradiance of a surface that faces the sun,
                                       W/m^2; spots and points: intensity, W/sr; patch: intensity along its
                                       normal, radiance x area, W/sr */
    float radius;                   /* of a sun alone: half the side of its map, world units, above 0, at most
                                       1e9 */
    float cone_half_angle;          /* of a spot: from its axis to its rim, above 0.0005, at most 3.14; of a
                                       square spot: from its axis to the middle of a side, at most 1 */
    float near_depth, far_depth;    /* the map holds surfaces between these distances along a face's axis, up
                                       to 1e9; near_depth is above 0 but for a sun. Both 0 = -radius..radius
                                       (sun), 0.001..1000 (others); to set one set both */
} rsm_light;

typedef enum rsm_rows {             /* which row of a picture in memory comes first */
    RSM_ROWS_DEFAULT,               /* = RSM_ROWS_BOTTOM_FIRST */
    RSM_ROWS_BOTTOM_FIRST,          /* the row at clip y = -1, as in OpenGL and Vulkan */
    RSM_ROWS_TOP_FIRST,             /* the row at clip y = +1, as in Direct3D and Metal, and in Vulkan with a
                                       viewport of negative height */
    RSM_ROWS_COUNT
} rsm_rows;

typedef enum rsm_clip_depth {       /* what clip z / w is at near_depth and at far_depth */
    RSM_CLIP_DEPTH_DEFAULT,         /* = RSM_CLIP_DEPTH_MINUS_ONE_TO_ONE */
    RSM_CLIP_DEPTH_MINUS_ONE_TO_ONE, /* OpenGL; depth buffers hold 0..1 */
    RSM_CLIP_DEPTH_ZERO_TO_ONE,     /* Direct3D, Metal, Vulkan */
    RSM_CLIP_DEPTH_REVERSED,        /* 1 near and 0 far */
    RSM_CLIP_DEPTH_COUNT
} rsm_clip_depth;

typedef enum rsm_clip_y {           /* where clip y points in your pictures */
    RSM_CLIP_Y_DEFAULT,             /* = RSM_CLIP_Y_UP */
    RSM_CLIP_Y_UP,
    RSM_CLIP_Y_DOWN,                /* Vulkan without a viewport of negative height: rsm_map_matrix is turned
                                       round */
    RSM_CLIP_Y_COUNT
} rsm_clip_y;

typedef struct rsm_desc {           /* zero it, then set what you care about; a sun needs direction and
                                       radius */
    rsm_system     system;
    rsm_light      light;
    uint32_t       side;            /* texels a side of each face, 4..4096; 0 = 512, cubes 256 */
    rsm_clip_depth clip_depth;      /* of rsm_map_matrix, and of depth buffers given to rsm_fill */
    rsm_clip_y     clip_y;          /* of rsm_map_matrix and of your pictures */
    rsm_rows       rows;            /* of the buffers given to rsm_fill */
} rsm_desc;

typedef int (*rsm_mask_fn)(void *user, uint32_t triangle, const float weights[3]);
/* A function of yours that says whether a triangle is there: not 0, or 0 in a hole of its alpha mask. The
   weights of the triangle's corners, which add up to 1, say at which point. parallel_for's threads call the
   function. */

typedef struct rsm_mesh {           /* triangles that the light may see */
    const float    *positions;      /* x, y, z of each vertex */
    size_t          vertex_count;
    size_t          vertex_stride;  /* bytes from one vertex to the next, a multiple of 4, >= 12; 0 = 12 */
    const uint32_t *indices;        /* three to a triangle; NULL = indices16, or else 0, 1, 2, ... */
    size_t          index_count;    /* a multiple of 3 (ignored without indices: vertex_count is used) */
    const uint16_t *indices16;      /* in place of indices; not both */
    const float    *transform;      /* object to world, 16 floats, affine (the last row counts as 0 0 0 1);
                                       NULL = none */
    float           albedo[3];      /* linear reflectance, 0..1 (only above 1e6 is it refused), where
                                       surface_fn is NULL */
    uint32_t        material;       /* number of the Phong lobe of the mesh's texels, from 1; 0 = none */
    rsm_mask_fn     mask_fn;        /* holes of an alpha mask, asked for at centres of texels; NULL = none */
    void (*surface_fn)(void *user, const struct rsm_mesh *mesh, uint32_t triangle, const float weights[3],
                       float albedo[3]);
    /* A function of yours that writes the linear albedo at a point of a triangle, which the weights of its
       corners say. NULL = `albedo` everywhere. parallel_for's threads call the function. */
    void           *user;           /* given to mask_fn and surface_fn */
    uint32_t        version;        /* of what mask_fn and surface_fn say, for rsm_redraw: another number
                                       whenever that changes; 0 = it may have changed, so that the map is
                                       drawn */
    uint32_t        tap_side;       /* surface_fn is averaged over tap_side x tap_side points of a texel, but
                                       for those in holes, so that textures finer than texels neither flicker
                                       nor lose energy. 1..16, 0 = 1 */
} rsm_mesh;

typedef struct rsm_points {         /* receivers: pixels of a picture, row by row, or any list */
    size_t          count;
    const float    *positions;      /* x, y, z of each, world */
    size_t          position_stride; /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const float    *normals;        /* unit; 0 0 0: no receiver, its results are 0 */
    size_t          normal_stride;  /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const float    *open;           /* share of bounced light that reaches each, 1 = all, as in glTF's ambient
                                       occlusion: a factor, of which more than 1 counts as 1, less than 0
                                       and NaN as 0; NULL = 1 */
    size_t          open_stride;    /* bytes, a multiple of 4; 0 = 4 */
    uint32_t        width;          /* pixels in a row of the picture; 0 = no picture */
    const uint32_t *indices;        /* only these points are lit, each once; NULL = all */
    size_t          index_count;
} rsm_points;

/* ==== src/rsm/api_maps.h ==== */

/* ---- maps ---- */

typedef struct rsm_info {           /* what a map is like */
    uint32_t side;                  /* texels a side of each face */
    uint32_t face_count;            /* 1, 5 (patch) or 6 (point, wide spot) */
    size_t   texel_count;           /* side x side x face_count */
    int      finished;              /* not 0: rsm_finish has been called */
} rsm_info;

RSM_DEF void rsm_get_info(const rsm_map *map, rsm_info *out);
/* Writes what a map is like. If map or out is NULL, nothing is written. */

#define RSM_FAR 3.0e38f             /* depth of a texel in which the light sees nothing */

typedef struct rsm_texel {          /* what the light sees through one pixel; also a pixel light: 48 bytes */
    float    position[3];           /* of the surface at the texel's centre */
    float    depth;                 /* along the face's axis, counted from the light's position; RSM_FAR: the
                                       light sees nothing there */
    float    normal[3];             /* unit */
    uint32_t material;              /* number of its Phong lobe in rsm_gather_desc.materials, from 1;
                                       0 = none */
    float    flux[3];               /* r, g, b, W that leave the surface: light through the texel x albedo */
    float    area;                  /* area of surface that the texel stands for, unit^2; 0 = unknown */
} rsm_texel;

RSM_DEF const rsm_texel *rsm_map_texels(const rsm_map *map);
/* Returns the map's texels, face by face and row by row, row 0 at the bottom (v = 0), as they are at this
   moment. NULL for NULL. */

RSM_DEF rsm_result rsm_map_restart(rsm_map *map, const rsm_light *light);
/* Empties a map for the next frame, in the memory that the map has.
   light    the light as it is now; NULL = as it was. The map keeps its side, and it cannot have more faces
            than it was made with: a spot that widens to a cube needs a map that was made for a cube
   Errors   after these the map is as it was.
            RSM_ERR_ARGUMENT: map is NULL.
            RSM_ERR_DESC: a field of light is out of range.
            RSM_ERR_LIMIT: the light needs more faces than the map was made with. */

RSM_DEF rsm_result rsm_redraw(rsm_map *map, const rsm_light *light, const rsm_mesh *meshes, size_t mesh_count,
                              int *kept, struct rsm_stats *stats);
/* Draws a map for the next frame as rsm_map_restart, rsm_rasterize and rsm_finish do, unless it would come
   out as it is: then the map is kept, byte for byte. Nobody has to say what moved: light and meshes are read,
   and compared with those of the last such call by a key of 64 bits, so that a change is missed once in 2^64.
   What is compared is what the arrays hold, not where they lie. What functions of a mesh say cannot be read:
   such a mesh is drawn in every frame unless its version is not 0.
   light    the light as it is now; NULL = as it was
   kept     whether the map was kept, written on RSM_OK; may be NULL
   stats    those of rsm_finish, of kept maps too; may be NULL
   Errors   those of the three calls but RSM_ERR_ORDER. After RSM_ERR_ARGUMENT and RSM_ERR_DESC the map is as
            it was; after others it may be empty, and no map for rsm_gather
   Cost     of a kept map: reading all vertices and indices, and scratch of 40 bytes for 32,768 of them */

RSM_DEF size_t rsm_map_bytes(const rsm_desc *desc);
/* Returns the bytes of memory that rsm_map_init needs: 56 a texel, 8 a row and at most 1 KB more. Returns 0
   if desc is NULL, and also, with a line in the log, if a field of desc is out of range. */

RSM_DEF rsm_result rsm_map_init(const rsm_desc *desc, void *memory, size_t memory_bytes, rsm_map **out);
/* Makes an empty map inside memory of yours. Nothing is allocated, and rsm_map_free leaves the map alone.
   memory   at least rsm_map_bytes(desc) bytes, 8-byte aligned; they must outlive *out
   Errors   RSM_ERR_ARGUMENT: desc, memory or out is NULL.
            RSM_ERR_DESC: a field of desc is out of range.
            RSM_ERR_LIMIT: size_t cannot count the bytes.
            RSM_ERR_MEMORY: the memory is too small, or not 8-byte aligned. */

/* ---- maps from your renderer ---- */

RSM_DEF rsm_result rsm_map_matrix(const rsm_map *map, uint32_t face, float world_to_clip[16]);
/* Writes the matrix, world to clip, with which your renderer draws a face of the map. The faces of a cube
   look forward, right, left, up, down and back in the orientation of the light's direction and up.
   Errors   RSM_ERR_ARGUMENT: map or world_to_clip is NULL, or there is no such face. */

RSM_DEF rsm_result rsm_map_project(const rsm_map *map, const float point[3], uint32_t *face, float uv[2],
                                   float *depth);
/* Writes where the light sees a point in the world.
   face     the face that the point lies in
   uv       0..1 from the left and from the bottom of the face; beyond if the point lies outside the map
   depth    as in rsm_texel. In a perspective map depth <= 0 says that the point lies behind the light; face
            is then 0 and uv the middle
   Errors   RSM_ERR_ARGUMENT: a pointer is NULL. RSM_ERR_INPUT: the point is not finite or beyond 1e9. */

typedef struct rsm_buffers {        /* one face as your renderer drew it: `side` rows of `side` pixels each,
                                       row after row */
    const float    *positions;      /* world; NULL: computed from depth */
    size_t          position_stride; /* bytes from one pixel to the next, a multiple of 4, >= 12; 0 = 12 */
    const float    *depth;          /* what a depth buffer holds, as clip_depth says. If there are positions,
                                       depth only marks the background, by the far value, and may be NULL */
    size_t          depth_stride;   /* bytes, a multiple of 4; 0 = 4 */
    const float    *normals;        /* world, any length. 0 0 0 marks the background */
    size_t          normal_stride;  /* as position_stride */
    const float    *albedo;         /* linear reflectance, 0..1: more is not refused */
    size_t          albedo_stride;  /* as position_stride */
    const uint8_t  *albedo_srgb;    /* 8-bit sRGB, used if albedo is NULL. If both are NULL the albedo is 1 */
    size_t          albedo_srgb_stride; /* bytes, >= 3; 0 = 4 */
    const uint32_t *materials;      /* numbers of Phong lobes; NULL: none */
    size_t          material_stride; /* as depth_stride */
} rsm_buffers;

RSM_DEF rsm_result rsm_fill(rsm_map *map, uint32_t face, const rsm_buffers *buffers);
/* Fills one face from your renderer's buffers. Pixels with a value that is not finite or a negative albedo
   become empty and are counted.
   Errors   RSM_ERR_ARGUMENT: map, buffers or normals are NULL, there are neither positions nor depth, there
            is no such face, or a stride is out of range.
            RSM_ERR_ORDER: the map is finished.
            RSM_ERR_CANCELLED: the face is empty. */

typedef struct rsm_stats {          /* what rsm_finish counts */
    uint64_t lit_texels;            /* texels that have flux */
    uint64_t bad_texels;            /* texels that were left empty, since a value of theirs was not finite,
                                       negative or above 1e18 */
    uint64_t skipped_triangles;     /* triangles of rsm_rasterize without area, or with a vertex that is not
                                       finite or beyond 1e9 */
    double   incident[3];           /* light that falls on texels with a surface, r, g, b, W */
    double   reflected[3];          /* light that leaves these: the sum of their flux, r, g, b, W */
} rsm_stats;

#ifndef RSM_WITHOUT_DIRECT
/* ---- direct light by the same map ---- */

typedef struct rsm_direct_desc {    /* zero it, then set what you care about */
    rsm_system system;              /* without a log, as without a desc, the map's is told */
    uint32_t   tap_side;            /* percentage-closer filter of tap_side x tap_side texels, 1..15; 0 = 2,
                                       bilinear */
    float      bias;                /* texels, towards the light, up to 1e6; 0 = 0.5, negative = none */
    float      slope_bias;          /* a factor, up to 1e6, on the further bias that keeps a plane out of its
                                       own shadow: what its slope, counted up to 10, makes over all taps.
                                       0 = 1, negative = none */
    int        add;                 /* not 0: results are added to what the output holds */
} rsm_direct_desc;

RSM_DEF rsm_result rsm_direct(const rsm_map *map, const rsm_direct_desc *desc, const rsm_points *points,
                              float *irradiance);
/* Writes the irradiance of the light itself, shadowed by the map: 3 floats for each point. A point that lies
   outside the map is lit by a sun, dark otherwise. points.open is not used.
   desc     NULL = all defaults
   Errors   those of rsm_gather, without RSM_ERR_ALLOC */
#endif

/* ==== src/rsm/api_gather.h ==== */

/* ---- bounced light ---- */

typedef enum rsm_pattern {          /* which texels a receiver takes its light from, if not from all */
    RSM_PATTERN_DEFAULT,            /* = RSM_PATTERN_FLUX */
    RSM_PATTERN_FLUX,               /* texels chosen in proportion to their flux, the same for all
                                       receivers */
    RSM_PATTERN_EQUATION3,          /* the paper's pattern about the receiver's projection, of density 1/r */
    RSM_PATTERN_LOG_RADIAL,         /* about the projection, of density 1/r^2 beyond r_min and even inside */
    RSM_PATTERN_POISSON,            /* about the projection, of even density over a disc, with a least
                                       distance between samples; 4096 samples at most */
    RSM_PATTERN_LOW_DISCREPANCY,    /* about the projection, of even density over a disc, by a
                                       (0, 2)-sequence */
    RSM_PATTERN_MIXED,              /* two fifths of the samples as in FLUX, three fifths as in LOG_RADIAL
                                       with r_min 1/192, put together by multiple importance sampling: the
                                       least error in corners, but slower. r_max and r_min are not used */
    RSM_PATTERN_COUNT
} rsm_pattern;

typedef struct rsm_material {       /* a Phong lobe that texels have beside their diffuse flux: the share of
                                       the incident light that it reflects is `specular` at most */
    float specular[3];              /* r, g, b, 0..1 */
    float exponent;                 /* 0..1e4 */
} rsm_material;

typedef void (*rsm_visible_fn)(void *user, const float position[3], const float normal[3],
                               const uint32_t *numbers, size_t count, float *visible);
/* A function of yours that writes how much of each light a receiver sees. ism.h and csm.h have functions of
   this type, ism_see and cohsm_see, which answer from their maps. Several threads of parallel_for may call
   the function at once.
   normal    that of rsm_points
   numbers   which lights are asked for: in rsm_gather_list their numbers in the list; in rsm_gather and
             rsm_interpolate their numbers in the list that rsm_pixel_lights writes for the same maps,
             sample_count and seed. Only lights that could light the receiver are asked for
   count     1..64
   visible   count floats: 0 = hidden, 1 = seen; more counts as 1, less and NaN as 0 */

typedef struct rsm_gather_desc {    /* zero it, then set what you care about */
    rsm_system  system;             /* without a log, as without a desc, the first map's is told */
    rsm_pattern pattern;
    uint32_t    sample_count;       /* texels that each receiver takes of each map, 1..2^20; 0 = every texel,
                                       whatever the pattern */
    int         paper_weights;      /* of EQUATION3; not 0: samples have the paper's weights, xi^2 normalised,
                                       which are biased; 0: each has the area that it stands for */
    float       r_max;              /* radius of patterns about the receiver, in sides of the map, 0..1000;
                                       of cubes the sine of half the angle (1 = all round). Above 0: samples
                                       outside the map count as dark, and light beyond r_max is lost. 0: each
                                       ray of the pattern ends at the map's border */
    float       r_min;              /* of LOG_RADIAL: the radius of its even disc, as a share of the
                                       pattern's, 0 or more, below 1; 0 = 1/32 */
    float       offset;             /* world units by which pixel lights move below their surface, 0..1e9
                                       (section 3.2) */
    float       clamp;              /* bound on cos cos / d^2, 1 / unit^2, up to 1e18; 0 = none */
    float       near_limit;         /* bound on the irradiance that one light gives, in units of its own
                                       radiosity (an infinite wall gives 1), up to 1e6; 0 = none. Texels
                                       without an area are not bounded */
    float       near_field;         /* 0 = all texels are points. Above 0, at most 32: a texel that is nearer
                                       to the receiver than near_field times its side (the root of its area)
                                       lights it as the parallelogram of surface that the texel is, by the
                                       exact form factor. 3 leaves no bright spots in corners. Works with
                                       sample_count 0 and with patterns about the receiver; lights chosen by
                                       flux and lists stay points. offset moves these texels, near_limit and
                                       clamp bound them like points; their Phong lobes are evaluated at their
                                       centre */
    uint32_t    seed;               /* chooses between equally good sets of samples. If gifilter.h takes the
                                       mean of several frames, count the seed up with each frame */
    const float *noise;             /* noise_side^2 floats in 0..1, tiled over the picture, by which each
                                       pixel's pattern is turned (but FLUX). rsm_blue_noise makes such. NULL =
                                       all patterns stand alike */
    uint32_t    noise_side;         /* 1..4096 */
    uint32_t    interleave;         /* k = 1, 2, 4, 8; 0 = 1. Above 1 the samples are dealt out to k x k sets,
                                       and pixel (x, y) takes set x % k + k (y % k) alone: k^2 times faster,
                                       and a grid of noise, which gifilter.h with log2 k passes smooths.
                                       Pictures alone have pixels (points->width) */
    const rsm_material *materials;  /* Phong lobes: texels with material m have materials[m - 1]. NULL: all
                                       texels are diffuse. FLUX chooses by diffuse flux, so that the lobes of
                                       black texels need sample_count 0 or a pattern about the receiver */
    uint32_t    material_count;     /* of materials */
    int         add;                /* not 0: results are added to those that are there, of other lists or of
                                       light maps; 0: results are written */
    rsm_visible_fn visible_fn;      /* shadows of the bounced light. Needs lights that all receivers share:
                                       sample_count 0, the pattern FLUX, or a list. Black texels give no light
                                       then, not even by lobes. NULL = every light is seen */
    void       *visible_user;       /* given to visible_fn */
} rsm_gather_desc;

typedef struct rsm_gather_stats {   /* what a gather counted */
    uint64_t evaluated;             /* receivers for which light was gathered */
    uint64_t pairs;                 /* pairs of a receiver and a pixel light that were evaluated */
    uint64_t bad_points;            /* receivers that are not finite or beyond 1e9; their results are 0 */
    double   clamped_share;         /* the light that clamp and near_limit took off, as a share of the light
                                       without them, all channels together */
    double   outside_share;         /* the share of flux that lies beyond r_max, as the mean over 64
                                       receivers */
} rsm_gather_stats;

#ifndef RSM_WITHOUT_INTERPOLATION
/* ---- pictures by interpolation (section 4) ---- */

typedef struct rsm_interpolation {  /* zero it, then set what you care about */
    uint32_t step;                  /* pixels between samples of the coarse grid, a power of two, 2..64;
                                       0 = 8 */
    uint32_t level_count;           /* grids that are tried, each of half the step, before the pixels left are
                                       evaluated one by one: 1 (as in the paper) to 6; 0 = 6 */
    float    normal_cosine;         /* the least cosine between a sample's normal and the pixel's, -1..1;
                                       0 = 0.95 */
    float    plane_slope;           /* how far a sample may lie off the pixel's plane, as a share of its
                                       distance from the pixel, 0..1e6; 0 = 0.05 */
    float    distance;              /* how far a sample may be from the pixel, world units, 0..1e9; 0 = no
                                       limit */
    float    contrast;              /* the grid is refined if the largest difference of the samples is above
                                       this share of their mean, up to 1e6. 0 = 0.25; negative = never, as in
                                       the paper */
    float    light_share;           /* a sample is used only for pixels within this share, up to 1e6, of the
                                       distance from the sample to its nearest pixel light, so that no bright
                                       spot between samples is missed. 0 = 0.25; negative = no limit */
    uint8_t *mask;                  /* a byte a pixel, written: 0 no receiver, 1 interpolated, 2 evaluated.
                                       NULL = not wanted */
} rsm_interpolation;

RSM_DEF rsm_result rsm_interpolate(const rsm_map *const *maps, size_t map_count, const rsm_gather_desc *desc,
                                   const rsm_interpolation *interpolation, const rsm_points *points,
                                   float *irradiance, rsm_gather_stats *stats);
/* Writes the irradiance of all pixels of a picture, as rsm_gather does, but faster: light is gathered on a
   coarse grid of pixels, and interpolated for a pixel if 3 or 4 samples about it lie on a surface like its
   own. The grid is refined for the other pixels, and light is gathered for what is left.
   desc     NULL = all defaults; noise, interleave and add must be off
   interpolation   NULL = all defaults
   points   a picture: width is set, count is a multiple of width below 2^32, and indices is NULL
   stats    may be NULL; evaluated / points->count is the share of pixels for which light was gathered
   Errors   those of rsm_gather, and these.
            RSM_ERR_ARGUMENT: the points are no picture.
            RSM_ERR_DESC: a field of interpolation is out of range, or noise, interleave or add is not off. */
#endif

#ifndef RSM_WITHOUT_LISTS
/* ---- lists of pixel lights ---- */

RSM_DEF rsm_result rsm_gather_list(const rsm_texel *lights, size_t count, const rsm_gather_desc *desc,
                                   const rsm_points *points, float *irradiance, rsm_gather_stats *stats);
/* Writes the irradiance that reaches each receiver from a list of pixel lights, as rsm_gather does from maps.
   The lights may come from rsm_pixel_lights, from rsm_cluster or from anywhere else.
   lights   position, normal (unit), flux and, for near_limit, area are read. Lights that are not finite,
            beyond 1e9, of negative flux or above 1e18 W are left out
   desc     NULL = all defaults. pattern, sample_count, r_max, r_min, seed, noise, near_field and materials
            are not used
   Errors   those of rsm_gather.
            RSM_ERR_INPUT: also if a light's normal is not unit, nor 0 0 0. */

RSM_DEF rsm_result rsm_pixel_lights(const rsm_map *const *maps, size_t map_count, uint32_t sample_count,
                                    uint32_t seed, rsm_texel *lights, size_t capacity, size_t *count);
/* Writes a list of pixel lights that stands for whole maps.
   sample_count  texels that are chosen of each map, in proportion to their flux, 1..2^20; their flux and area
                 are scaled, so that the sum stays. 0 = every lit texel
   seed          chooses between equally good samples
   lights        room for capacity lights; may be NULL if capacity is 0
   count         how many lights there are, written on RSM_OK and on RSM_ERR_MEMORY: ask first with capacity 0
   Errors        the log is that of the first map.
                 RSM_ERR_ARGUMENT: a pointer is NULL, map_count is 0, or sample_count is above 2^20.
                 RSM_ERR_ORDER: a map is not finished.
                 RSM_ERR_MEMORY: capacity is below *count. */

RSM_DEF rsm_result rsm_cluster(const rsm_texel *lights, size_t light_count, uint32_t cluster_count,
                               const rsm_system *system, rsm_texel *clusters, size_t *count);
/* Groups lights into at most cluster_count larger ones. The flux and area of a group are sums, its position
   and normal are means by flux; if its normals cancel out, its normal is that of its brightest light. Lights
   that are not finite, beyond 1e9, without flux or above 1e18 W are left out.
   light_count    below 2^31
   cluster_count  1..65536
   system    may be NULL
   clusters  room for cluster_count lights, of which *count are written; none if there is no flux
   Errors    RSM_ERR_ARGUMENT: a pointer is NULL, or cluster_count is out of range.
             RSM_ERR_DESC: the allocator is not whole.
             RSM_ERR_INPUT: a light's normal is not unit, nor 0 0 0.
             RSM_ERR_LIMIT: light_count is 2^31 or more.
             RSM_ERR_ALLOC: there is no memory.
   Cost      scratch of 4 bytes a light and 128 a cluster */
#endif

/* ---- patterns ---- */

RSM_DEF rsm_result rsm_pattern_build(rsm_pattern pattern, uint32_t sample_count, float r_min,
                                     int paper_weights, uint32_t seed, float *points);
/* Writes one of the patterns about the receiver, for a renderer of your own: a list of samples in the unit
   disc. The mean of a function f over the disc is sum(weight f) / pi.
   pattern        neither FLUX nor MIXED, which are no discs
   sample_count   1..2^20, of POISSON 1..4096
   r_min, paper_weights, seed   as in rsm_gather_desc
   points         3 floats for each sample: x, y and weight
   Errors         this call has no log.
                  RSM_ERR_ARGUMENT: points is NULL, or pattern, sample_count or r_min is out of range. */

RSM_DEF rsm_result rsm_blue_noise(uint32_t side, uint32_t seed, const rsm_system *system, float *values);
/* Makes noise for rsm_gather_desc.noise whose neighbours differ as much as can be, by void and cluster
   (Ulichney 1993). The tile goes on at its borders.
   side      4..64
   system    may be NULL
   values    side^2 floats: (i + 0.5) / side^2 for each i, in the order that makes the noise
   Errors    RSM_ERR_ARGUMENT: values is NULL, or side is out of range.
             RSM_ERR_DESC: the allocator is not whole.
             RSM_ERR_ALLOC: there is no memory.
   Cost      a time of O(side^4), scratch of 4 bytes a value */

#ifdef __cplusplus
}
#endif

#endif /* RSM_H */

/* ==== src/rsm/begin.h ==== */

/* ==== implementation ==================================================================================== */

#if defined(RSM_IMPLEMENTATION) && !defined(RSM_IMPLEMENTED)

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The name of this file, by which it includes itself (see kernels_begin.h). Define RSM_FILE if you renamed
   it. */
#ifndef RSM_FILE
#define RSM_FILE "rsm.h"
#endif
#define RSM__FILE RSM_FILE

#ifdef RSM_NO_SIMD
#define RSM__NO_SIMD
#endif

/* ==== src/shared/fp_begin.h ==== */

/* unit fp_begin: the arithmetic that the bytes depend on, from here to unit fp_end */

/* Forbids fused multiply-adds that the source does not ask for: gcc fuses across statements in its gnu modes
   and on s390x, clang within expressions. For gcc, the pragmas take a user's -ffast-math back. In clang,
   -ffast-math and -ffp-contract=fast win over the pragma: results then stay within tolerance, but are not
   equal to the bit. */
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#define RSM__FINITE_MATH 1
#else
#define RSM__FINITE_MATH 0
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

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
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

/* Returns 1 if so many bytes may lie between elements of floats that are `standard` bytes large: 0, which
   stands for `standard`, or a multiple of 4 with which elements do not overlap. */
static inline int rsm__stride_valid(size_t stride, size_t standard)
{
    return stride == 0 || (stride >= standard && stride % 4 == 0);
}

/* Returns 1 if the functions of a public allocator are both there or both NULL. */
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

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
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

/* ==== src/shared/v3.h ==== */

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

/* Returns a + b s. */
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

/* Returns a with length 1. The largest component scales the others first, so that neither tiny nor huge
   vectors leave the range of floats. The zero vector stays zero. */
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

/* Returns 1 if x is finite, by its exponent bits: under -ffast-math compilers may take isfinite() for always
   true. */
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

/* Writes b1 and b2, which are orthonormal and right-handed together with a unit n; n.z may be -0 or -1. Duff
   et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017. */
static inline void rsm__v3_basis(rsm__v3 n, rsm__v3 *b1, rsm__v3 *b2)
{
    float s = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + n.z), b = n.x * n.y * a;
    *b1 = rsm__v3_make(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
    *b2 = rsm__v3_make(b, s + n.y * n.y * a, -n.y);
}

/* ==== src/shared/unit.h ==== */

/* unit unit: which vectors count as unit, the same in every header (src/README.md, "Unit vectors") */

/* The squares of the least and the greatest length that count as 1: an 8-bit normal map makes such
   vectors. */
#define RSM__UNIT_LEAST2 0.9409f       /* 0.97^2 */
#define RSM__UNIT_MOST2 1.0609f        /* 1.03^2 */

/* Says whether a vector is unit, by the square of its length. If that is not a number, the vector is not. */
static inline int rsm__is_unit2(float length2)
{
    return length2 >= RSM__UNIT_LEAST2 && length2 <= RSM__UNIT_MOST2;
}

/* ==== src/shared/trig.h ==== */

/* unit trig: elementary functions with the same bits on every machine */

/* These functions use + - * / and sqrt alone, which IEEE 754 rounds the same everywhere as long as nothing
   is contracted (unit fp_begin). Coefficients are minimax fits of our own. The float functions are free of
   branches and calls, so that loops over them vectorise at SSE2 level. The errors named below are the
   largest differences from the double functions, over all float arguments or a dense set
   (tests/shared/units_test.c). Arguments out of range and NaN are clamped into the range, so that nothing
   here is undefined or returns NaN. */

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

/* Returns |x| with the sign bit of s; s = -0 counts as negative. */
static inline float rsm__copysign(float x, float s)
{
    return rsm__from_bits((rsm__to_bits(x) & 0x7fffffffu) | (rsm__to_bits(s) & 0x80000000u));
}

/* Returns a if yes is 1 and b if it is 0, without a branch: compilers turn a chain of ?: with one condition
   into a branch, and then do not vectorise the loop round it. */
static inline float rsm__either(int yes, float a, float b)
{
    uint32_t mask = 0u - (uint32_t)yes;
    return rsm__from_bits((rsm__to_bits(a) & mask) | (rsm__to_bits(b) & ~mask));
}

/* Writes sine and cosine of |x| <= 8192 with an absolute error of 1e-7. As in Cody and Waite, pi/2 has three
   parts, of which the first two times k are exact for |k| < 2^13. */
static inline void rsm__sincos(float x, float *sine, float *cosine)
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
static inline float rsm__atan2(float y, float x)
{
    float ax = fabsf(x), ay = fabsf(y);
    float a, t, z, p;
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

/* Returns exp(x) as 2^k (1 + r + r^2 p(r)) with |r| <= ln 2 / 2, in double, so that exp, log and pow err by
   1 ulp. */
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
    p = 0.500000007785776445 + r * (0.166666668605852527 + r * (0.0416662700968242239 +
        r * (0.00833326438132814496 + r * p)));
    bits = (uint64_t)(k + 1023) << 52;
    memcpy(&power, &bits, sizeof power);
    return power * (1.0 + (r + r * r * p));
}

/* Returns the logarithm of x > 0 from x = 2^e m with m in [sqrt(1/2), sqrt(2)), by
   log m = 2 artanh((m - 1) / (m + 1)). */
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
    z *= 0.333333328227282264 + z * (0.200001675954362054 + z * (0.142686542711926518 +
         z * 0.117910756496012977));
    return (double)e * 0.69314718055994531 + 2.0 * (s + s * z);
}

/* Returns exp(x), which is infinity above 88.7228394. */
static inline float rsm__exp(float x)
{
    return x > 88.7228394f ? rsm__from_bits(0x7f800000u) : (float)rsm__exp_core((double)x);
}

/* Returns the natural logarithm of x, or -infinity if x is not above 0. */
static inline float rsm__log(float x)
{
    return x > 0.0f ? (float)rsm__log_core(x) : rsm__from_bits(0xff800000u);
}

/* Returns x^y. x below 0 counts as 0; 0^y is 0, 1 or infinity for y above, equal to or below 0. */
static inline float rsm__pow(float x, float y)
{
    double t;
    if (y == 0.0f) return 1.0f;
    if (!(x > 0.0f)) return y > 0.0f ? 0.0f : rsm__from_bits(0x7f800000u);
    t = (double)y * rsm__log_core(x);
    return t > 88.722839111 ? rsm__from_bits(0x7f800000u) : (float)rsm__exp_core(t);
}

/* ==== src/shared/rng.h ==== */

/* unit rng: hashes and random numbers, the same on every machine */

/* Returns a hash by the output function of O'Neill's PCG: Jarzynski and Olano, "Hash functions for GPU
   rendering", JCGT 9(3), 2020. */
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

/* Returns the upper 24 bits as a number in [0, 1). Every such value is a float; the largest is 1 - 2^-24. */
static inline float rsm__to_unit(uint32_t bits) { return (float)(bits >> 8) * (1.0f / 16777216.0f); }

/* Returns number i, in [0, 1), of the stream (seed, stream). There is no state, so that threads and tiles
   can draw their own numbers. */
static inline float rsm__random(uint32_t seed, uint32_t stream, uint32_t i)
{
    return rsm__to_unit(rsm__hash_combine(rsm__hash_combine(seed, stream), i));
}

/* ==== src/shared/lds.h ==== */

/* unit lds, needs rng: low-discrepancy points in [0, 1) */

static inline uint32_t rsm__reverse_bits(uint32_t x)
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
static inline uint32_t rsm__owen(uint32_t x, uint32_t seed)
{
    x = rsm__reverse_bits(x) + seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return rsm__reverse_bits(x);
}

/* Writes point i of a scrambled (0, 2)-sequence, which has the first two dimensions of Sobol's. The order is
   shuffled, too, so that sequences of different seeds may be combined to more dimensions. */
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

/* ==== src/shared/cpu.h ==== */

/* unit cpu: run-time detection of x86 vector units */

/* RSM__X86 is 1 if functions with target attributes can be compiled and chosen at run time. RSM__NO_SIMD, which
   the header defines from its public switch, makes it 0. tcc has no such attributes, so that it is 0 there;
   MSVC needs none. For clang in MSVC's place (clang-cl) it is 0, since this compiler hides the vector types
   unless the whole program is built for them. */
#if defined(RSM__NO_SIMD) || defined(__TINYC__)
#define RSM__X86 0
#elif defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
#define RSM__X86 1
#define RSM__TARGET_AVX2 __attribute__((target("avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#define RSM__TARGET_AVX512 \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#elif defined(_MSC_VER) && defined(_M_X64) && !defined(__clang__)
#define RSM__X86 1
#define RSM__TARGET_AVX2
#define RSM__TARGET_AVX512
#else
#define RSM__X86 0
#endif

/* These ask the processor directly: the compilers' own functions ask the same, but add 4.5 KB to every
   program. */
#if RSM__X86 && defined(_MSC_VER)
#include <intrin.h>
static inline void rsm__cpu_ask(unsigned leaf, unsigned *r) { __cpuidex((int *)r, (int)leaf, 0); }
static inline unsigned rsm__cpu_xcr0(void) { return (unsigned)_xgetbv(0); }
#elif RSM__X86
#include <cpuid.h>
static inline void rsm__cpu_ask(unsigned leaf, unsigned *r)
{
    __cpuid_count(leaf, 0, r[0], r[1], r[2], r[3]);
}
static inline unsigned rsm__cpu_xcr0(void)
{
    unsigned low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}
#endif

#if RSM__X86
/* Returns 1 if all of these bits are set in ebx of cpuid's leaf 7, the processor has FMA and POPCNT, and the
   operating system saves the registers that the bits of xcr0 stand for. Every processor with BMI2 has
   LZCNT. */
static inline int rsm__cpu_leaf7(unsigned xcr0, unsigned ebx)
{
    const unsigned wanted = 1u << 12 | 1u << 23 | 1u << 27;     /* FMA, POPCNT, OSXSAVE */
    unsigned r[4];
    rsm__cpu_ask(0, r);
    if (r[0] < 7) return 0;
    rsm__cpu_ask(1, r);
    if ((r[2] & wanted) != wanted || (rsm__cpu_xcr0() & xcr0) != xcr0) return 0;
    rsm__cpu_ask(7, r);
    return (r[1] & ebx) == ebx;
}
/* Asks for AVX2, BMI and BMI2, and for the registers of SSE and AVX. */
static inline int rsm__cpu_has_avx2(void) { return rsm__cpu_leaf7(0x06u, 0x00000128u); }
/* Asks for F, DQ, BW and VL of AVX-512 besides, and for its mask registers and wide registers. */
static inline int rsm__cpu_has_avx512(void) { return rsm__cpu_leaf7(0xe6u, 0xc0030128u); }
#else
static inline int rsm__cpu_has_avx2(void) { return 0; }
static inline int rsm__cpu_has_avx512(void) { return 0; }
#endif

/* ==== src/shared/batch.h ==== */

/* unit batch: tasks of a call, some at a time */

typedef struct rsm__batch { void (*task)(void *context, size_t index); void *context; size_t first; } rsm__batch;

/* The task of a batch, with the batch as its context. */
static inline void rsm__batch_task(void *context, size_t index)
{
    const rsm__batch *b = (const rsm__batch *)context;
    b->task(b->context, b->first + index);
}

/* ==== src/shared/hot.h ==== */

/* unit hot, needs fp_begin: attributes of functions that take most of the time */

#if defined(__GNUC__) && !defined(__TINYC__)
#define RSM__PREFETCH(p) __builtin_prefetch(p)
#else
#define RSM__PREFETCH(p) (void)(p)
#endif

/* ==== src/shared/simd.h ==== */

/* unit simd, needs cpu: one text of a kernel for every instruction set */

/* A kernel is written once, for rsm__lanes: RSM__LANE_COUNT floats, of which the instruction set RSM__SET
   computes RSM__WIDTH at a time. What lies between unit simd_begin and the last kernel of a header is compiled
   once for every set that the program may meet. It is first compiled in its place, as set "plain", for what
   the whole program is compiled for (SSE2, NEON, the 128 bits of WebAssembly, or one float at a time). Then,
   if RSM__SIMD_SETS is 1, the header includes itself with RSM__SET, RSM__WIDTH and RSM__LANE_COUNT defined
   anew: avx2 with 8 lanes, avx512 with 16. rsm__simd_level returns which set to call. With RSM__NO_SIMD there
   are no intrinsics; the compiler's own vectors, which are portable, stay if RSM__COMPILER_VECTORS is
   defined. RSM__FILE is the header's name; a header pasted into another file cannot include itself: "plain".

   What is compiled several times needs a name for each set. The list below makes rsm__lanes_add the name
   rsm__lanes_add_avx2 in set avx2; the header has such a list for its kernels. RSM__KERNEL stands before a
   kernel, RSM__IN_KERNEL before what is inlined into kernels.

   Every set gives the same bits, but for rsm__lanes_muladd, which rounds once in avx2 and avx512, twice
   elsewhere. */
#if defined(RSM__NO_SIMD) && (!defined(RSM__COMPILER_VECTORS) || defined(__i386__))
#define RSM__SCALAR 1
#else
#define RSM__SCALAR 0
#endif
#if RSM__X86
#include <immintrin.h>
#define RSM__SIMD_SETS 1
#else
#define RSM__SIMD_SETS 0
#endif
#if RSM__X86 && (defined(__x86_64__) || defined(_M_X64))
#define RSM__SIMD_X86 1
#define RSM__SIMD_VECTORS 0
#define RSM__SIMD_WIDTH 4
#elif !RSM__X86 && !RSM__SCALAR && (defined(__GNUC__) || defined(__clang__)) && !defined(__TINYC__)
#define RSM__SIMD_X86 0
#define RSM__SIMD_VECTORS 1
#define RSM__SIMD_WIDTH 4
#else
#define RSM__SIMD_X86 0
#define RSM__SIMD_VECTORS 0
#define RSM__SIMD_WIDTH 1
#endif
#ifdef __has_include
#if !__has_include(RSM__FILE)
#undef RSM__SIMD_SETS
#define RSM__SIMD_SETS 0
#endif
#endif
#if RSM__SIMD_VECTORS && defined(__aarch64__) && !defined(RSM__NO_SIMD)
#include <arm_neon.h>
#elif RSM__SIMD_VECTORS && defined(__wasm_simd128__) && !defined(RSM__NO_SIMD)
#include <wasm_simd128.h>
#endif

#define RSM__NAME_OF_SET(name, set) name##_##set
#define RSM__NAME_IN_SET(name, set) RSM__NAME_OF_SET(name, set)
#define rsm__lanes RSM__NAME_IN_SET(rsm__lanes, RSM__SET)
#define rsm__lane_mask RSM__NAME_IN_SET(rsm__lane_mask, RSM__SET)
#define rsm__lane_ints RSM__NAME_IN_SET(rsm__lane_ints, RSM__SET)
#define rsm__piece RSM__NAME_IN_SET(rsm__piece, RSM__SET)
#define rsm__piece_ints RSM__NAME_IN_SET(rsm__piece_ints, RSM__SET)
#define rsm__piece_words RSM__NAME_IN_SET(rsm__piece_words, RSM__SET)
#define rsm__lanes_load RSM__NAME_IN_SET(rsm__lanes_load, RSM__SET)
#define rsm__lanes_store RSM__NAME_IN_SET(rsm__lanes_store, RSM__SET)
#define rsm__lanes_all RSM__NAME_IN_SET(rsm__lanes_all, RSM__SET)
#define rsm__lanes_add RSM__NAME_IN_SET(rsm__lanes_add, RSM__SET)
#define rsm__lanes_sub RSM__NAME_IN_SET(rsm__lanes_sub, RSM__SET)
#define rsm__lanes_mul RSM__NAME_IN_SET(rsm__lanes_mul, RSM__SET)
#define rsm__lanes_div RSM__NAME_IN_SET(rsm__lanes_div, RSM__SET)
#define rsm__lanes_max RSM__NAME_IN_SET(rsm__lanes_max, RSM__SET)
#define rsm__lanes_min RSM__NAME_IN_SET(rsm__lanes_min, RSM__SET)
#define rsm__lanes_negate RSM__NAME_IN_SET(rsm__lanes_negate, RSM__SET)
#define rsm__lanes_greater RSM__NAME_IN_SET(rsm__lanes_greater, RSM__SET)
#define rsm__lanes_at_least RSM__NAME_IN_SET(rsm__lanes_at_least, RSM__SET)
#define rsm__lanes_select RSM__NAME_IN_SET(rsm__lanes_select, RSM__SET)
#define rsm__lanes_keep RSM__NAME_IN_SET(rsm__lanes_keep, RSM__SET)
#define rsm__lanes3 RSM__NAME_IN_SET(rsm__lanes3, RSM__SET)
#define rsm__lanes3_load RSM__NAME_IN_SET(rsm__lanes3_load, RSM__SET)
#define rsm__lanes3_all RSM__NAME_IN_SET(rsm__lanes3_all, RSM__SET)
#define rsm__lanes3_sub RSM__NAME_IN_SET(rsm__lanes3_sub, RSM__SET)
#define rsm__lanes3_dot RSM__NAME_IN_SET(rsm__lanes3_dot, RSM__SET)
#define rsm__mask_and RSM__NAME_IN_SET(rsm__mask_and, RSM__SET)
#define rsm__ints_load RSM__NAME_IN_SET(rsm__ints_load, RSM__SET)
#define rsm__ints_store RSM__NAME_IN_SET(rsm__ints_store, RSM__SET)
#define rsm__ints_all RSM__NAME_IN_SET(rsm__ints_all, RSM__SET)
#define rsm__ints_or RSM__NAME_IN_SET(rsm__ints_or, RSM__SET)
#define rsm__ints_keep RSM__NAME_IN_SET(rsm__ints_keep, RSM__SET)

/* Returns 2 if AVX-512 may be used, 1 if AVX2 may be, otherwise 0. */
static inline int rsm__simd_level(void)
{
    if (!RSM__SIMD_SETS || !rsm__cpu_has_avx2()) return 0;
    return rsm__cpu_has_avx512() ? 2 : 1;
}

/* ==== src/shared/message.h ==== */

/* unit message: one line for the caller's log that says why a call failed */

/* RSM__COLD stands before functions that are needed only by calls that fail: compilers make these functions
   small, and take branches to them for unlikely. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define RSM__COLD __attribute__((cold))
#else
#define RSM__COLD
#endif

/* Where a message goes, and the name of the function that failed. If log is NULL, nothing is written. */
typedef struct rsm__logger {
    void (*log)(void *user, const char *message);
    void *user;
    const char *function;
} rsm__logger;

typedef struct rsm__message { char text[256]; size_t used; } rsm__message;

/* Appends a text; what does not fit is cut off. */
static inline RSM__COLD void rsm__message_text(rsm__message *m, const char *s)
{
    while (*s && m->used + 1 < sizeof m->text) m->text[m->used++] = *s++;
    m->text[m->used] = 0;
}

static inline RSM__COLD void rsm__message_count(rsm__message *m, uint64_t value)
{
    char digits[24];
    size_t at = sizeof digits - 1;
    digits[at] = 0;
    do digits[--at] = (char)('0' + (int)(value % 10));
    while ((value /= 10) != 0);
    rsm__message_text(m, digits + at);
}

/* Writes six significant digits without the zeros at their end. Returns how many digits are left and writes
   *exponent, the power of ten of the first one. value is finite and above 0. */
static inline RSM__COLD int rsm__message_digits(double value, char digits[8], int *exponent)
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
static inline RSM__COLD void rsm__message_number(rsm__message *m, double value)
{
    char digits[8], first[2] = { 0, 0 };
    int exponent, count, i;

    if (value != value) {
        rsm__message_text(m, "not a number");
        return;
    }
    if (value < 0.0) rsm__message_text(m, "-");
    if (value < 0.0) value = -value;
    if (!(value > 0.0) || value > 1.7976931348623157e308) {
        rsm__message_text(m, value > 0.0 ? "infinity" : "0");
        return;
    }
    if (value < 9007199254740992.0 && value - (double)(uint64_t)value <= 0.0) {
        rsm__message_count(m, (uint64_t)value);
        return;
    }
    count = rsm__message_digits(value, digits, &exponent);
    first[0] = digits[0];
    if (exponent < -4 || exponent > 9) {
        rsm__message_text(m, first);
        if (count > 1) rsm__message_text(m, ".");
        rsm__message_text(m, digits + 1);
        rsm__message_text(m, exponent < 0 ? "e-" : "e");
        rsm__message_count(m, (uint64_t)(exponent < 0 ? -exponent : exponent));
        return;
    }
    if (exponent < 0) rsm__message_text(m, "0.");
    for (i = exponent; i < -1; i++) rsm__message_text(m, "0");
    for (i = 0; i < count; i++) {
        if (exponent >= 0 && i == exponent + 1) rsm__message_text(m, ".");
        first[0] = digits[i];
        rsm__message_text(m, first);
    }
    for (i = count; i <= exponent; i++) rsm__message_text(m, "0");
}

/* Begins a line: "FUNCTION: FIELD". */
static inline RSM__COLD void rsm__message_begin(rsm__message *m,
                                          const rsm__logger *logger, const char *field)
{
    m->used = 0;
    rsm__message_text(m, logger->function);
    rsm__message_text(m, ": ");
    rsm__message_text(m, field);
}

/* Logs "FUNCTION: FIELD TEXT", as in "cohsm_build: mesh.positions is NULL". */
static inline RSM__COLD void rsm__log_text(const rsm__logger *logger, const char *field, const char *text)
{
    rsm__message m;
    if (!logger->log) return;
    rsm__message_begin(&m, logger, field);
    rsm__message_text(&m, " ");
    rsm__message_text(&m, text);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: FIELD is VALUE; it must be WANTED", as in "cohsm_build: desc.map_side is 3; it must be 0 or
   4..1024". */
static inline RSM__COLD void rsm__log_value(const rsm__logger *logger, const char *field, double value,
                                      const char *wanted)
{
    rsm__message m;
    if (!logger->log) return;
    rsm__message_begin(&m, logger, field);
    rsm__message_text(&m, " is ");
    rsm__message_number(&m, value);
    rsm__message_text(&m, "; it must be ");
    rsm__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: ARRAY[INDEX] WHAT VALUE; it must be WANTED", as in "rsm_gather: normals[17] has the length
   0.5; it must be 1 (0.97..1.03), or 0". */
static inline RSM__COLD void rsm__log_element(const rsm__logger *logger, const char *array, uint64_t index,
                                        const char *what, double value, const char *wanted)
{
    rsm__message m;
    if (!logger->log) return;
    rsm__message_begin(&m, logger, array);
    rsm__message_text(&m, "[");
    rsm__message_count(&m, index);
    rsm__message_text(&m, "] ");
    rsm__message_text(&m, what);
    rsm__message_text(&m, " ");
    rsm__message_number(&m, value);
    rsm__message_text(&m, "; it must be ");
    rsm__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: ARRAY[INDEX] TEXT", as in "cohsm_merge: shards[3] is NULL". */
static inline RSM__COLD void rsm__log_element_text(const rsm__logger *logger, const char *array, uint64_t index,
                                             const char *text)
{
    rsm__message m;
    if (!logger->log) return;
    rsm__message_begin(&m, logger, array);
    rsm__message_text(&m, "[");
    rsm__message_count(&m, index);
    rsm__message_text(&m, "] ");
    rsm__message_text(&m, text);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: mesh: index 2 of triangle 17 is 90, but the mesh has 80 vertices". position counts the
   indices from 0. */
static inline RSM__COLD void rsm__log_index(const rsm__logger *logger, const char *mesh,
                                      uint64_t position, uint64_t index, uint64_t vertex_count)
{
    rsm__message m;
    if (!logger->log) return;
    rsm__message_begin(&m, logger, mesh);
    rsm__message_text(&m, ": index ");
    rsm__message_count(&m, position % 3);
    rsm__message_text(&m, " of triangle ");
    rsm__message_count(&m, position / 3);
    rsm__message_text(&m, " is ");
    rsm__message_count(&m, index);
    rsm__message_text(&m, ", but the mesh has ");
    rsm__message_count(&m, vertex_count);
    rsm__message_text(&m, vertex_count == 1 ? " vertex" : " vertices");
    logger->log(logger->user, m.text);
}

/* ==== src/shared/bound.h ==== */

/* unit bound, needs message: the line for a number that is beyond what an object or an earlier call allows */

/* Logs "FUNCTION: FIELD is VALUE; it must be RELATION BOUND, NAME", as in "cohsm_view: view is 9; it must be
   below 8, the number of views". */
static inline RSM__COLD void rsm__log_bound(const rsm__logger *logger, const char *field, uint64_t value,
                                      const char *relation, uint64_t bound, const char *name)
{
    rsm__message m;
    m.used = 0;
    rsm__message_text(&m, relation);
    rsm__message_text(&m, " ");
    rsm__message_count(&m, bound);
    rsm__message_text(&m, ", ");
    rsm__message_text(&m, name);
    rsm__log_value(logger, field, (double)value, m.text);
}

/* ==== src/rsm/arguments.h ==== */

/* ---- arguments: results, strides, systems, points ---- */

#define RSM__PI 3.14159265f
#define RSM__MAX_FLOAT 3.40282347e38f

enum {
    RSM__LANES = 8,          /* pixel lights that the kernel takes at once */
    RSM__WIDE = 16,          /* lanes of the widest vectors */
    RSM__BLOCK = 64,         /* pixel lights in one block of arrays */
    RSM__RUN = 1024,         /* pixel lights in one sum */
    RSM__BATCH = 32,         /* receivers of a task */
    RSM__FEW = 128,          /* the most pixel lights of a set that go one by one to a vector of receivers */
    RSM__MAX_SIDE = 4096,
    RSM__MAX_SAMPLES = 1 << 20,
    RSM__MAX_POISSON = 4096
};

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

static inline size_t rsm__stride_or(size_t stride, size_t standard) { return stride ? stride : standard; }

/* Returns the address of element i of an array whose elements lie `stride` bytes apart. */
static inline const float *rsm__element_at(const float *base, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)(const void *)base + i * stride);
}

/* Returns element i of an array of three floats each; stride 0 is 12. */
static inline rsm__v3 rsm__vector_at(const float *base, size_t stride, size_t i)
{
    return rsm__v3_load(rsm__element_at(base, rsm__stride_or(stride, 12), i));
}

/* Returns whether a vector is finite and small enough for squares and fourth powers of floats. */
static inline int rsm__is_usable(rsm__v3 v)
{
    return fabsf(v.x) <= 1e9f && fabsf(v.y) <= 1e9f && fabsf(v.z) <= 1e9f;      /* false for NaN */
}

/* Returns where a call says why it fails. system may be NULL. */
static inline rsm__logger rsm__logger_of(const rsm_system *system, const char *function)
{
    rsm__logger log;
    log.log = system ? system->log : NULL;
    log.user = system ? system->user : NULL;
    log.function = function;
    return log;
}

/* Logs that a field is what the text says, as in "map is finished", and returns the result. */
static inline rsm_result rsm__refuse(const rsm__logger *log, rsm_result result, const char *field,
                                     const char *text)
{
    rsm__log_text(log, field, text);
    return result;
}

/* Returns whether a value lies within low..high, and logs the field if it does not. NaN does not. */
static inline int rsm__check_range(const rsm__logger *log, const char *field, double value, double low,
                              double high, const char *wanted)
{
    if (value >= low && value <= high) return 1;
    rsm__log_value(log, field, value, wanted);
    return 0;
}

/* Returns whether a face is one of a map's, and logs it if it is not. */
static inline int rsm__check_face(const rsm__logger *log, uint32_t face, uint32_t count)
{
    if (face < count) return 1;
    rsm__log_bound(log, "face", face, "below", count, "the number of faces");
    return 0;
}

/* Returns whether all three components of a vector are finite and at most `most`, and logs one that is not.
   */
static inline int rsm__check_vector(const rsm__logger *log, const char *field, const float v[3], double most,
                                    const char *wanted)
{
    return rsm__check_range(log, field, (double)v[0], -most, most, wanted) &&
           rsm__check_range(log, field, (double)v[1], -most, most, wanted) &&
           rsm__check_range(log, field, (double)v[2], -most, most, wanted);
}

/* Returns whether a system's allocator is whole or left out, and logs if it is not. */
static inline int rsm__system_valid(const rsm__logger *log, const rsm_system *s)
{
    if (rsm__allocator_valid(s->allocator.alloc_fn, s->allocator.free_fn)) return 1;
    rsm__log_text(log, "system.allocator", "has one of its two functions");
    return 0;
}

static inline rsm__allocator rsm__allocator_of(const rsm_system *s)
{
    return rsm__allocator_make(s->allocator.alloc_fn, s->allocator.free_fn, s->allocator.user);
}

/* Runs count tasks, by the caller's parallel_for if there is one. */
static inline void rsm__run_tasks(const rsm_system *s, size_t count, rsm_task task, void *context)
{
    size_t i;
    if (s->parallel_for) s->parallel_for(s->user, count, task, context);
    else
        for (i = 0; i < count; i++) task(context, i);
}

/* Tells the caller how far the call is, and returns whether the caller cancels it. */
static inline int rsm__cancelled(const rsm_system *s, float fraction)
{
    return s->progress && s->progress(s->user, fraction) != 0;
}

/* Runs count tasks in steps, between which the caller may cancel. begin and end are the fractions of the
   whole call at which this part begins and ends. Returns 0 if the caller cancelled. */
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
        rsm__run_tasks(s, next - batch.first, rsm__batch_task, &batch);
        batch.first = next;
    }
    return 1;
}

/* Returns whether a stride is in range, and logs the field if it is not. */
static inline int rsm__check_stride(const rsm__logger *log, const char *field, size_t stride,
                                      size_t standard)
{
    if (rsm__stride_valid(stride, standard)) return 1;
    rsm__log_value(log, field, (double)stride,
                   standard == 12 ? "0 or a multiple of 4 from 12 on" : "0 or a multiple of 4 from 4 on");
    return 0;
}

/* Returns whether a normal is one that arrays may hold: unit, 0 0 0, or not finite. */
static inline int rsm__unit_or_none(const float n[3])
{
    const float length2 = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    if (rsm__is_unit2(length2)) return 1;
    return (n[0] == 0.0f && n[1] == 0.0f && n[2] == 0.0f) || !(length2 <= RSM__MAX_FLOAT);
}

/* Logs that normal i of an array is not unit, and returns the result. */
static inline rsm_result rsm__refuse_normal(const rsm__logger *log, const char *array, size_t i, rsm__v3 n)
{
    rsm__log_element(log, array, i, "has the length", (double)rsm__v3_length(n), "1 (0.97..1.03), or 0");
    return RSM_ERR_INPUT;
}

/* Returns 1 if all of `count` normals, `stride` floats apart, are unit, as is the rule. Returns 0 if each has
   to be looked at by itself, since 0 0 0 and normals that are not finite are allowed too. Keeps the least and
   the largest of four lengths apart, so that one comparison need not wait for the one before. */
static inline int rsm__all_unit(const float *n, size_t stride, size_t count)
{
    float low[4] = { 1, 1, 1, 1 }, high[4] = { 1, 1, 1, 1 };
    size_t i, l;
    for (i = 0; i + 4 <= count; i += 4)
        for (l = 0; l < 4; l++, n += stride) {
            float length2 = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
            low[l] = length2 < low[l] ? length2 : low[l];
            high[l] = length2 > high[l] ? length2 : high[l];
        }
    for (l = 0; l < 4; l++)
        if (low[l] < RSM__UNIT_LEAST2 || high[l] > RSM__UNIT_MOST2) return 0;
    return i == count;
}

/* Checks the normals of receivers, 64 at a time, and logs the first that is not unit. */
static inline rsm_result rsm__normals_check(const rsm__logger *log, const rsm_points *p)
{
    const size_t stride = rsm__stride_or(p->normal_stride, 12) / 4, block = 64;
    size_t i, k, count = p->indices ? p->index_count : p->count;
    for (i = 0; i < count; i += block) {
        const size_t end = count - i < block ? count : i + block;
        if (!p->indices && rsm__all_unit(p->normals + i * stride, stride, end - i)) continue;
        for (k = i; k < end; k++) {
            const size_t at = p->indices ? p->indices[k] : k;
            const float *n = p->normals + at * stride;
            if (!rsm__unit_or_none(n)) return rsm__refuse_normal(log, "points.normals", at, rsm__v3_load(n));
        }
    }
    return RSM_OK;
}

/* Checks pointers, strides and indices of receivers, then the lengths of their normals. */
static inline rsm_result rsm__points_check(const rsm__logger *log, const rsm_points *p, const float *out)
{
    const rsm_result bad = RSM_ERR_ARGUMENT;
    size_t i, bytes;
    if (!p) return rsm__refuse(log, bad, "points", "is NULL");
    if (p->count && !p->positions) return rsm__refuse(log, bad, "points.positions", "is NULL");
    if (p->count && !p->normals) return rsm__refuse(log, bad, "points.normals", "is NULL");
    if (p->count && !out) return rsm__refuse(log, bad, "irradiance", "is NULL");
    if (!rsm__check_stride(log, "points.position_stride", p->position_stride, 12)) return bad;
    if (!rsm__check_stride(log, "points.normal_stride", p->normal_stride, 12)) return bad;
    if (!rsm__check_stride(log, "points.open_stride", p->open_stride, 4)) return bad;
    if (!rsm__mul_size(p->count, 12, &bytes)) {
        rsm__log_value(log, "points.count", (double)p->count, "less: size_t cannot count the bytes");
        return RSM_ERR_LIMIT;
    }
    for (i = 0; p->indices && i < p->index_count; i++)
        if (p->indices[i] >= p->count) {
            rsm__log_element(log, "points.indices", i, "is", p->indices[i], "below points.count");
            return RSM_ERR_INPUT;
        }
    return p->count ? rsm__normals_check(log, p) : RSM_OK;
}

/* Loads receiver i. Returns 0 if it is none: its normal is 0 0 0, or it is not finite, which *bad counts. */
static inline int rsm__load_receiver(const rsm_points *p, size_t i, rsm__v3 *x, rsm__v3 *n, uint64_t *bad)
{
    *x = rsm__vector_at(p->positions, p->position_stride, i);
    *n = rsm__vector_at(p->normals, p->normal_stride, i);
    if (n->x == 0.0f && n->y == 0.0f && n->z == 0.0f) return 0;
    if (rsm__is_usable(*x) && rsm__is_usable(*n)) return 1;
    ++*bad;
    return 0;
}

static inline float rsm__mean3(const float *rgb) { return (rgb[0] + rgb[1] + rgb[2]) * (1.0f / 3.0f); }
static inline float rsm__fraction(float x) { return x - floorf(x); }

/* ==== src/rsm/map.h ==== */

/* ---- map: orientations of faces, projection, matrices ---- */

struct rsm_map {
    rsm_desc   desc;               /* with its defaults filled in */
    uint32_t   side, faces;        /* texels a side; how many faces there are */
    uint32_t   room;               /* how many faces the memory holds */
    int        finished;           /* rsm_finish was called */
    int        owned;              /* the memory is ours to free */
    rsm__v3    right, up, axis;    /* of face 0; the light travels along axis */
    float      extent;             /* half the side of a face: of a sun in world units, of others at distance
                                      1 */
    float      cos_half;           /* the cosine of a spot's half angle; -1 for other lights */
    rsm_stats  stats;
    uint64_t   key;                /* of what rsm_redraw drew; 0 = something else may be in the map */
    rsm_texel *texels;
    double    *rows;               /* side * faces + 1 running sums: the flux of all rows before each */
    double    *sums;               /* the flux of each row up to and including the texel */
};

/* Returns where a call says why it fails whose desc may be NULL or without a log: to the map's then. Each of
   the two may be NULL. */
static inline rsm__logger rsm__logger_of_map(const rsm_system *system, const rsm_map *map,
                                             const char *function)
{
    return rsm__logger_of((system && system->log) || !map ? system : &map->desc.system, function);
}

static inline size_t rsm__texel_count(const rsm_map *map)
{
    return (size_t)map->side * map->side * map->faces;
}

static inline int rsm__is_sun(const rsm_map *map) { return map->desc.light.kind == RSM_LIGHT_SUN; }

/* Writes right, up and axis of a face. Faces 0 to 5 of a cube look along axis, right, left, up, down and
   back; a patch has no face that looks back. */
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

/* Returns whether a light has a cube, as spots have above a half angle of 1. */
static inline int rsm__has_cube(const rsm_light *l)
{
    return l->kind == RSM_LIGHT_POINT || l->kind == RSM_LIGHT_PATCH ||
           (l->kind == RSM_LIGHT_SPOT && l->cone_half_angle > 1.0f);
}

/* Returns whether the depths between which a face holds surfaces are in range, and logs if they are not. */
static inline int rsm__check_depths(const rsm__logger *log, const rsm_light *l)
{
    const double low = l->kind == RSM_LIGHT_SUN ? -1e9 : 1e-30;
    if (!rsm__check_range(log, "light.near_depth", (double)l->near_depth, low, 1e9,
                     l->kind == RSM_LIGHT_SUN ? "-1e9..1e9" : "above 0, at most 1e9"))
        return 0;
    if (l->far_depth > l->near_depth && l->far_depth <= 1e9f) return 1;
    rsm__log_value(log, "light.far_depth", (double)l->far_depth, "above near_depth, at most 1e9");
    return 0;
}

/* Returns whether a light has what its kind needs, a direction, a radius, a cone, and logs if it has not. */
static inline int rsm__check_shape(const rsm__logger *log, const rsm_light *l)
{
    float length = rsm__v3_length(rsm__v3_load(l->direction));
    if (l->kind != RSM_LIGHT_POINT && !(length > 1e-15f && length <= 1e15f)) {
        rsm__log_value(log, "the length of light.direction", (double)length, "above 0");
        return 0;
    }
    if (l->kind == RSM_LIGHT_SUN && !(l->radius > 0.0f && l->radius <= 1e9f)) {
        rsm__log_value(log, "light.radius", (double)l->radius, "above 0, at most 1e9");
        return 0;
    }
    if (l->kind == RSM_LIGHT_SPOT && !(l->cone_half_angle > 0.5e-3f && l->cone_half_angle <= 3.14f)) {
        rsm__log_value(log, "light.cone_half_angle", (double)l->cone_half_angle,
                       "above 0.0005, at most 3.14");
        return 0;
    }
    if (l->kind == RSM_LIGHT_SQUARE_SPOT && !(l->cone_half_angle > 0.5e-3f && l->cone_half_angle <= 1.0f)) {
        rsm__log_value(log, "light.cone_half_angle", (double)l->cone_half_angle, "above 0.0005, at most 1");
        return 0;
    }
    return 1;
}

/* Checks a light and fills in its defaults. */
static inline rsm_result rsm__light_check(const rsm__logger *log, rsm_light *l)
{
    const rsm_result bad = RSM_ERR_DESC;
    int i;
    if (!rsm__check_range(log, "light.kind", (double)l->kind, 0, RSM_LIGHT_COUNT - 1,
                     "one of rsm_light_kind"))
        return bad;
    if (l->kind == RSM_LIGHT_DEFAULT) l->kind = RSM_LIGHT_SUN;
    if (!rsm__check_vector(log, "light.position", l->position, 1e9, "-1e9..1e9")) return bad;
    if (!rsm__check_vector(log, "light.direction", l->direction, (double)RSM__MAX_FLOAT, "finite"))
        return bad;
    if (!rsm__check_vector(log, "light.up", l->up, (double)RSM__MAX_FLOAT, "finite")) return bad;
    for (i = 0; i < 3; i++)
        if (!rsm__check_range(log, "light.value", (double)l->value[i], 0, (double)1e12f, "0..1e12"))
            return bad;
    if (!rsm__check_shape(log, l)) return bad;
    if (l->near_depth == 0.0f && l->far_depth == 0.0f) {
        l->near_depth = l->kind == RSM_LIGHT_SUN ? -l->radius : 1e-3f;
        l->far_depth = l->kind == RSM_LIGHT_SUN ? l->radius : 1e3f;
    }
    return rsm__check_depths(log, l) ? RSM_OK : bad;
}

/* Checks a desc and fills in its defaults. */
static inline rsm_result rsm__desc_check(const rsm__logger *log, rsm_desc *d)
{
    rsm_result result = rsm__light_check(log, &d->light);
    if (result != RSM_OK) return result;
    if (!rsm__system_valid(log, &d->system)) return RSM_ERR_DESC;
    if (d->side == 0) d->side = rsm__has_cube(&d->light) ? 256 : 512;
    if (!rsm__check_range(log, "desc.side", d->side, 4, RSM__MAX_SIDE, "0 or 4..4096")) return RSM_ERR_DESC;
    if (!rsm__check_range(log, "desc.clip_depth", (double)d->clip_depth, 0, RSM_CLIP_DEPTH_COUNT - 1,
                     "one of rsm_clip_depth"))
        return RSM_ERR_DESC;
    if (!rsm__check_range(log, "desc.clip_y", (double)d->clip_y, 0, RSM_CLIP_Y_COUNT - 1,
                          "one of rsm_clip_y"))
        return RSM_ERR_DESC;
    if (!rsm__check_range(log, "desc.rows", (double)d->rows, 0, RSM_ROWS_COUNT - 1, "one of rsm_rows"))
        return RSM_ERR_DESC;
    return RSM_OK;
}

/* Checks a desc and sets the map's orientation and sizes by it. If the desc is refused, the map stays as it
   is. */
static inline rsm_result rsm__set_map_desc(const rsm__logger *log, rsm_map *map, const rsm_desc *desc)
{
    rsm_desc d = *desc;
    rsm__v3 up;
    int cube;
    rsm_result result = rsm__desc_check(log, &d);
    if (result != RSM_OK) return result;
    cube = rsm__has_cube(&d.light);
    map->faces = !cube ? 1 : d.light.kind == RSM_LIGHT_PATCH ? 5 : 6;
    map->side = d.side;
    map->desc = d;
    map->axis = d.light.kind == RSM_LIGHT_POINT ? rsm__v3_make(0, 0, -1)
                                                : rsm__v3_normalize(rsm__v3_load(d.light.direction));
    if (d.light.kind == RSM_LIGHT_SUN) map->axis = rsm__v3_scale(map->axis, -1);
    up =
        rsm__v3_normalize(d.light.kind == RSM_LIGHT_POINT ? rsm__v3_make(0, 1, 0) : rsm__v3_load(d.light.up));
    if (rsm__v3_length(rsm__v3_cross(map->axis, up)) < 1e-3f)
        up = fabsf(map->axis.y) < 0.9f ? rsm__v3_make(0, 1, 0) : rsm__v3_make(0, 0, 1);
    map->right = rsm__v3_normalize(rsm__v3_cross(map->axis, up));
    map->up = rsm__v3_cross(map->right, map->axis);
    map->extent = 1.0f;
    map->cos_half = -1.0f;
    if (d.light.kind == RSM_LIGHT_SUN) map->extent = d.light.radius;
    else if (d.light.kind == RSM_LIGHT_SPOT || d.light.kind == RSM_LIGHT_SQUARE_SPOT) {
        float s, c;
        rsm__sincos(d.light.cone_half_angle, &s, &c);
        if (!cube) map->extent = s / c;
        if (d.light.kind == RSM_LIGHT_SPOT) map->cos_half = c;
    }
    return RSM_OK;
}

/* Returns where a point lies in a face: x and y in units of half the face's side, z as the depth. */
static inline rsm__v3 rsm__to_face(const rsm_map *map, uint32_t face, rsm__v3 p)
{
    rsm__v3 r, u, a, q = rsm__v3_sub(p, rsm__v3_load(map->desc.light.position));
    float z, scale;
    rsm__face_frame(map, face, &r, &u, &a);
    z = rsm__v3_dot(q, a);
    scale = rsm__is_sun(map) ? 1.0f / map->extent : 1.0f / (map->extent * z);
    return rsm__v3_make(rsm__v3_dot(q, r) * scale, rsm__v3_dot(q, u) * scale, z);
}

/* Returns the point at depth z under (x, y) of a face, both -1..1. */
static inline rsm__v3 rsm__from_face(const rsm_map *map, uint32_t face, float x, float y, float z)
{
    rsm__v3 r, u, a, p = rsm__v3_load(map->desc.light.position);
    float scale = rsm__is_sun(map) ? map->extent : map->extent * z;
    rsm__face_frame(map, face, &r, &u, &a);
    p = rsm__v3_madd(p, r, x * scale);
    p = rsm__v3_madd(p, u, y * scale);
    return rsm__v3_madd(p, a, z);
}

/* Returns the face by which a direction, given along right, up and axis of the light, leaves the cube. */
static inline uint32_t rsm__cube_face(float x, float y, float z)
{
    float ax = fabsf(x), ay = fabsf(y), az = fabsf(z);
    if (az >= ax && az >= ay) return z >= 0.0f ? 0 : 5;
    if (ax >= ay) return x >= 0.0f ? 1 : 2;
    return y >= 0.0f ? 3 : 4;
}

/* Returns the face that a point lies in; 5, which a patch does not have, for points behind the light. */
static inline uint32_t rsm__face_of(const rsm_map *map, rsm__v3 p)
{
    rsm__v3 q = rsm__v3_sub(p, rsm__v3_load(map->desc.light.position));
    if (map->faces == 1) return 0;
    return rsm__cube_face(rsm__v3_dot(q, map->right), rsm__v3_dot(q, map->up), rsm__v3_dot(q, map->axis));
}

/* Returns the coordinate, -1..1, of the centre of column or row i of a face. */
static inline float rsm__texel_centre(const rsm_map *map, uint32_t i)
{
    return ((float)i + 0.5f) * 2.0f / (float)map->side - 1.0f;
}

/* Returns the unit vector from a point of the scene to the light. */
static inline rsm__v3 rsm__to_light(const rsm_map *map, rsm__v3 p)
{
    if (rsm__is_sun(map)) return rsm__v3_scale(map->axis, -1);
    return rsm__v3_normalize(rsm__v3_sub(rsm__v3_load(map->desc.light.position), p));
}

static inline void rsm__texel_clear(rsm_texel *t)
{
    memset(t, 0, sizeof *t);
    t->depth = RSM_FAR;
}

RSM_DEF rsm_result rsm_map_matrix(const rsm_map *map, uint32_t face, float world_to_clip[16])
{
    rsm__v3 r, u, a, p;
    float n, f, sx;
    float sy, z[2], row[4][4];
    int i, k, perspective;
    rsm__logger log = rsm__logger_of(map ? &map->desc.system : NULL, "rsm_map_matrix");
    if (!map) return RSM_ERR_ARGUMENT;
    if (!world_to_clip) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "world_to_clip", "is NULL");
    if (!rsm__check_face(&log, face, map->faces)) return RSM_ERR_ARGUMENT;
    rsm__face_frame(map, face, &r, &u, &a);
    p = rsm__v3_load(map->desc.light.position);
    n = map->desc.light.near_depth;
    f = map->desc.light.far_depth;
    perspective = !rsm__is_sun(map);
    sx = 1.0f / map->extent;
    sy = map->desc.clip_y == RSM_CLIP_Y_DOWN ? -sx : sx;
    /* Clip z is z[0] depth + z[1], which perspective divides by w = depth. */
    z[0] = perspective ? f / (f - n) : 1.0f / (f - n);
    z[1] = perspective ? -n * f / (f - n) : -n / (f - n);
    if (map->desc.clip_depth == RSM_CLIP_DEPTH_REVERSED) {
        z[0] = perspective ? -n / (f - n) : -z[0];
        z[1] = perspective ? -z[1] : f / (f - n);
    } else if (map->desc.clip_depth != RSM_CLIP_DEPTH_ZERO_TO_ONE) {
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

RSM_DEF rsm_result rsm_map_project(const rsm_map *map, const float point[3], uint32_t *face, float uv[2],
                                   float *depth)
{
    rsm__v3 q;
    uint32_t f;
    rsm__logger log = rsm__logger_of(map ? &map->desc.system : NULL, "rsm_map_project");
    if (!map) return RSM_ERR_ARGUMENT;
    if (!point) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "point", "is NULL");
    if (!face) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "face", "is NULL");
    if (!uv) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "uv", "is NULL");
    if (!depth) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "depth", "is NULL");
    if (!rsm__check_vector(&log, "point", point, 1e9, "-1e9..1e9")) return RSM_ERR_INPUT;
    f = rsm__face_of(map, rsm__v3_load(point));
    if (f >= map->faces) f = 0; /* the point lies behind a patch */
    q = rsm__to_face(map, f, rsm__v3_load(point));
    if (!rsm__is_sun(map) && !(q.z > 0.0f)) q.x = q.y = 0.0f;
    *face = f;
    uv[0] = q.x * 0.5f + 0.5f;
    uv[1] = q.y * 0.5f + 0.5f;
    *depth = q.z;
    return RSM_OK;
}

/* ==== src/rsm/map_create.h ==== */

/* ---- maps: their memory ---- */

static inline size_t rsm__align_bytes(size_t bytes) { return (bytes + 15u) & ~(size_t)15u; }

/* Returns the bytes that a map whose desc is set needs, or 0 if that is more than size_t holds. */
static inline size_t rsm__map_bytes(const rsm_map *map)
{
    size_t rows = (size_t)map->side * map->faces, texels, bytes, sums;
    if (!rsm__mul_size(rows, map->side, &texels) || !rsm__mul_size(texels, sizeof(rsm_texel), &bytes))
        return 0;
    if (!rsm__mul_size(texels, sizeof(double), &sums) || !rsm__add_size(bytes, sums, &bytes)) return 0;
    if (!rsm__add_size(bytes, (rows + 1) * sizeof(double) + rsm__align_bytes(sizeof *map) + 64, &bytes))
        return 0;
    return bytes;
}

RSM_DEF size_t rsm_map_bytes(const rsm_desc *desc)
{
    rsm_map map;
    rsm__logger log = rsm__logger_of(desc ? &desc->system : NULL, "rsm_map_bytes");
    return desc && rsm__set_map_desc(&log, &map, desc) == RSM_OK ? rsm__map_bytes(&map) : 0;
}

/* Lays a map whose desc is set out in memory that is large enough, and empties it. */
static inline rsm_map *rsm__map_place(rsm_map map, void *memory)
{
    rsm_map *to = (rsm_map *)memory;
    char *at = (char *)memory + rsm__align_bytes(sizeof map);
    size_t i, texels = rsm__texel_count(&map);
    map.room = map.faces;
    map.texels = (rsm_texel *)(void *)at;
    at += rsm__align_bytes(texels * sizeof(rsm_texel));
    map.sums = (double *)(void *)at;
    map.rows = map.sums + texels;
    *to = map;
    for (i = 0; i < texels; i++) rsm__texel_clear(map.texels + i);
    return to;
}

RSM_DEF rsm_result rsm_map_init(const rsm_desc *desc, void *memory, size_t memory_bytes, rsm_map **out)
{
    rsm__logger log = rsm__logger_of(desc ? &desc->system : NULL, "rsm_map_init");
    rsm_map map;
    rsm_result result;
    if (!desc) return RSM_ERR_ARGUMENT;
    if (!memory) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "memory", "is NULL");
    if (!out) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "out", "is NULL");
    memset(&map, 0, sizeof map);
    result = rsm__set_map_desc(&log, &map, desc);
    if (result != RSM_OK) return result;
    if (rsm__map_bytes(&map) == 0) {
        rsm__log_value(&log, "desc.side", map.side, "less: size_t cannot count the bytes of the map");
        return RSM_ERR_LIMIT;
    }
    if (memory_bytes < rsm__map_bytes(&map)) {
        rsm__log_bound(&log, "memory_bytes", memory_bytes, "at least", rsm__map_bytes(&map),
                       "rsm_map_bytes(desc)");
        return RSM_ERR_MEMORY;
    }
    if ((uintptr_t)memory % 8 != 0)
        return rsm__refuse(&log, RSM_ERR_MEMORY, "memory", "is not 8-byte aligned");
    *out = rsm__map_place(map, memory);
    return RSM_OK;
}

RSM_DEF rsm_result rsm_map_create(const rsm_desc *desc, rsm_map **out)
{
    rsm__logger log = rsm__logger_of(desc ? &desc->system : NULL, "rsm_map_create");
    rsm_map map;
    rsm__allocator a;
    rsm_result result;
    void *memory;
    if (!desc) return RSM_ERR_ARGUMENT;
    if (!out) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "out", "is NULL");
    memset(&map, 0, sizeof map);
    result = rsm__set_map_desc(&log, &map, desc);
    if (result != RSM_OK) return result;
    if (rsm__map_bytes(&map) == 0) {
        rsm__log_value(&log, "desc.side", map.side, "less: size_t cannot count the bytes of the map");
        return RSM_ERR_LIMIT;
    }
    a = rsm__allocator_of(&desc->system);
    memory = rsm__alloc(&a, rsm__map_bytes(&map));
    if (!memory) return rsm__refuse(&log, RSM_ERR_ALLOC, "the allocator", "returned no memory for the map");
    *out = rsm__map_place(map, memory);
    (*out)->owned = 1;
    return RSM_OK;
}

RSM_DEF rsm_result rsm_map_restart(rsm_map *map, const rsm_light *light)
{
    rsm__logger log = rsm__logger_of(map ? &map->desc.system : NULL, "rsm_map_restart");
    rsm_map next;
    rsm_desc desc;
    rsm_result result;
    size_t i, texels;
    if (!map) return RSM_ERR_ARGUMENT;
    desc = map->desc;
    if (light) desc.light = *light;
    memset(&next, 0, sizeof next);
    result = rsm__set_map_desc(&log, &next, &desc);
    if (result != RSM_OK) return result;
    if (next.faces > map->room) {
        rsm__log_bound(&log, "the face count of light", next.faces, "at most", map->room,
                       "what the map was made with");
        return RSM_ERR_LIMIT;
    }
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

RSM_DEF void rsm_get_info(const rsm_map *map, rsm_info *out)
{
    if (!map || !out) return;
    out->side = map->side;
    out->face_count = map->faces;
    out->texel_count = rsm__texel_count(map);
    out->finished = map->finished;
}

RSM_DEF const rsm_texel *rsm_map_texels(const rsm_map *map) { return map ? map->texels : NULL; }

/* ==== src/rsm/flux.h ==== */

/* ---- flux: light through a texel, and sums of it ---- */

/* Returns the flux of a light of value 1 through the square (x, y) +- h in the plane of a face at distance 1.
   That is the integral of cos^3, for a patch times the cosine to its normal, by Gauss points: two an axis if
   the square is small, else four. It is exact to 1e-6, and nothing cancels as in the closed form by
   arctangents. The rim of a cone is left to rsm__texel_incident. */
static inline float rsm__solid_angle(const rsm_map *map, rsm__v3 r, rsm__v3 u, rsm__v3 a, float x, float y,
                                     float h)
{
    static const float node[6] = { -0.577350269f, 0.577350269f, -0.861136312f,
                                   -0.339981044f, 0.339981044f, 0.861136312f };
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

/* Returns whether the direction to (x, y) in the plane of a face at distance 1 lies in the spot's cone. */
static inline int rsm__in_cone(const rsm_map *map, rsm__v3 r, rsm__v3 u, rsm__v3 a, float x, float y)
{
    rsm__v3 d = rsm__v3_madd(rsm__v3_madd(a, r, x), u, y);
    return rsm__v3_dot(map->axis, d) >= map->cos_half * rsm__v3_length(d);
}

/* Returns the flux of a light of value 1 through a texel. A texel across the rim of a cone has the share of
   64 points that lie in the cone. */
static inline float rsm__texel_incident(const rsm_map *map, uint32_t face, uint32_t i, uint32_t j)
{
    rsm__v3 r, u, a;
    float h = map->extent / (float)map->side, x = rsm__texel_centre(map, i) * map->extent;
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
            covered += rsm__in_cone(map, r, u, a, x + h * ((float)k - 3.5f) * 0.25f,
                                    y + h * ((float)l - 3.5f) * 0.25f);
    return flux * (float)covered * (1.0f / 64.0f);
}

/* Sets one texel to a surface at a position, with the light that falls on it and leaves it. */
static inline void rsm__texel_set(rsm_map *map, uint32_t face, uint32_t i, uint32_t j, rsm__v3 position,
                                  rsm__v3 normal, const float albedo[3], uint32_t material)
{
    rsm_texel *t = map->texels + ((size_t)face * map->side + j) * map->side + i;
    rsm__v3 q = rsm__to_face(map, face, position);
    float incident = rsm__texel_incident(map, face, i, j), slope, distance;
    int c, bad;
    normal = rsm__v3_normalize(normal);
    bad = !rsm__is_usable(position) || !rsm__v3_finite(normal) || !rsm__finite(q.z);
    for (c = 0; c < 3; c++)
        bad |= !(albedo[c] >= 0.0f && albedo[c] * incident * map->desc.light.value[c] <= 1e18f);
    rsm__texel_clear(t);
    if (bad) {
        t->material = UINT32_MAX; /* by this rsm_finish counts the texel as bad */
        return;
    }
    rsm__v3_store(t->position, position);
    rsm__v3_store(t->normal, normal);
    t->depth = q.z;
    t->material = material == UINT32_MAX ? 0 : material;
    for (c = 0; c < 3; c++) t->flux[c] = incident * map->desc.light.value[c] * albedo[c];
    /* The area of surface under the texel: the cross section of its beam over the cosine, which counts as
       0.05 at least. */
    slope = fabsf(rsm__v3_dot(normal, rsm__to_light(map, position)));
    distance = rsm__is_sun(map) ? 1.0f : q.z * map->extent;
    t->area = 4.0f * distance * distance / ((float)map->side * (float)map->side) *
              (rsm__is_sun(map) ? map->extent * map->extent : 1.0f);
    if (!rsm__is_sun(map)) { /* the plane of the face cuts the beam at an angle */
        rsm__v3 r, u, a;
        rsm__face_frame(map, face, &r, &u, &a);
        t->area *= fabsf(rsm__v3_dot(a, rsm__to_light(map, position)));
    }
    t->area /= slope > 0.05f ? slope : 0.05f;
}

/* Makes the running sums of flux, in double, and the statistics. A texel that was marked as bad is counted
   here. */
static inline void rsm__sum_flux(rsm_map *map, int want_incident)
{
    size_t i, at = 0, rows = (size_t)map->side * map->faces, row;
    double total = 0.0;
    map->stats.lit_texels = map->stats.bad_texels = 0;
    for (i = 0; i < 3; i++) map->stats.incident[i] = map->stats.reflected[i] = 0.0;
    for (row = 0; row < rows; row++) {
        double sum = 0.0;
        map->rows[row] = total;
        for (i = 0; i < map->side; i++, at++) {
            rsm_texel *t = map->texels + at;
            int c;
            if (t->material == UINT32_MAX) {
                t->material = 0;
                map->stats.bad_texels++;
            }
            if (t->depth < RSM_FAR) {
                float f = !want_incident ? 0.0f
                                         : rsm__texel_incident(map, (uint32_t)(row / map->side), (uint32_t)i,
                                                               (uint32_t)(row % map->side));
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

RSM_DEF rsm_result rsm_finish(rsm_map *map, rsm_stats *stats)
{
    rsm__logger log = rsm__logger_of(map ? &map->desc.system : NULL, "rsm_finish");
    if (!map) return RSM_ERR_ARGUMENT;
    if (map->finished) return rsm__refuse(&log, RSM_ERR_ORDER, "map", "is finished already");
    rsm__sum_flux(map, stats != NULL);
    map->finished = 1;
    if (stats) *stats = map->stats;
    return RSM_OK;
}

/* ==== src/rsm/fill.h ==== */

/* ---- fill: a face from the buffers of a renderer ---- */

/* Returns the depth along the face that a value 0..1 of a depth buffer stands for. */
static inline float rsm__unproject_depth(const rsm_map *map, float stored)
{
    float n = map->desc.light.near_depth, f = map->desc.light.far_depth;
    if (map->desc.clip_depth == RSM_CLIP_DEPTH_REVERSED)
        return rsm__is_sun(map) ? f - stored * (f - n) : n * f / (n + stored * (f - n));
    if (rsm__is_sun(map)) return n + stored * (f - n);
    return n * f / (f - stored * (f - n));
}

static inline float rsm__from_srgb(uint8_t value)
{
    float s = (float)value * (1.0f / 255.0f);
    return s <= 0.04045f ? s * (1.0f / 12.92f) : rsm__pow((s + 0.055f) * (1.0f / 1.055f), 2.4f);
}

typedef struct rsm__filling {
    rsm_map *map;
    uint32_t face;
    const rsm_buffers *buffers;
    float srgb[256];
} rsm__filling;

/* Fills one texel from the buffers. */
static inline void rsm__fill_texel(const rsm__filling *f, uint32_t i, uint32_t j)
{
    rsm_map *map = f->map;
    const rsm_buffers *b = f->buffers;
    /* If the picture is turned, its first row is the top of the face, v = 1. */
    int turned = (map->desc.rows == RSM_ROWS_TOP_FIRST) != (map->desc.clip_y == RSM_CLIP_Y_DOWN);
    size_t at = (size_t)(turned ? map->side - 1u - j : j) * map->side + i;
    rsm__v3 normal = rsm__vector_at(b->normals, b->normal_stride, at), position;
    float stored = b->depth ? *rsm__element_at(b->depth, rsm__stride_or(b->depth_stride, 4), at) : 0.0f;
    float albedo[3] = { 1, 1, 1 };
    uint32_t material = 0;
    int c;
    rsm__texel_clear(map->texels + ((size_t)f->face * map->side + j) * map->side + i);
    if (normal.x == 0.0f && normal.y == 0.0f && normal.z == 0.0f) return;
    if (b->depth && (map->desc.clip_depth == RSM_CLIP_DEPTH_REVERSED ? stored <= 0.0f : stored >= 1.0f))
        return;
    if (b->positions) position = rsm__vector_at(b->positions, b->position_stride, at);
    else
        position = rsm__from_face(map, f->face, rsm__texel_centre(map, i), rsm__texel_centre(map, j),
                                  rsm__unproject_depth(map, stored));
    if (b->albedo) rsm__v3_store(albedo, rsm__vector_at(b->albedo, b->albedo_stride, at));
    else if (b->albedo_srgb)
        for (c = 0; c < 3; c++)
            albedo[c] = f->srgb[b->albedo_srgb[at * rsm__stride_or(b->albedo_srgb_stride, 4) + (size_t)c]];
    if (b->materials)
        memcpy(&material,
               (const char *)(const void *)b->materials + at * rsm__stride_or(b->material_stride, 4),
               sizeof material);
    rsm__texel_set(map, f->face, i, j, position, normal, albedo, material);
}

static inline void rsm__fill_row(void *context, size_t row)
{
    const rsm__filling *f = (const rsm__filling *)context;
    uint32_t i;
    for (i = 0; i < f->map->side; i++) rsm__fill_texel(f, i, (uint32_t)row);
}

static inline rsm_result rsm__buffers_check(const rsm__logger *log, const rsm_buffers *b)
{
    const rsm_result bad = RSM_ERR_ARGUMENT;
    if (!b) return rsm__refuse(log, bad, "buffers", "is NULL");
    if (!b->normals) return rsm__refuse(log, bad, "buffers.normals", "is NULL");
    if (!b->positions && !b->depth)
        return rsm__refuse(log, bad, "buffers.depth", "is NULL, and so is positions");
    if (!rsm__check_stride(log, "buffers.position_stride", b->position_stride, 12)) return bad;
    if (!rsm__check_stride(log, "buffers.depth_stride", b->depth_stride, 4)) return bad;
    if (!rsm__check_stride(log, "buffers.normal_stride", b->normal_stride, 12)) return bad;
    if (!rsm__check_stride(log, "buffers.albedo_stride", b->albedo_stride, 12)) return bad;
    if (!rsm__check_stride(log, "buffers.material_stride", b->material_stride, 4)) return bad;
    if (b->albedo_srgb_stride == 0 || b->albedo_srgb_stride >= 3) return RSM_OK;
    rsm__log_value(log, "buffers.albedo_srgb_stride", (double)b->albedo_srgb_stride, "0 or at least 3");
    return bad;
}

RSM_DEF rsm_result rsm_fill(rsm_map *map, uint32_t face, const rsm_buffers *buffers)
{
    rsm__logger log = rsm__logger_of(map ? &map->desc.system : NULL, "rsm_fill");
    rsm__filling f;
    rsm_result result;
    size_t i, texels;
    if (!map) return RSM_ERR_ARGUMENT;
    result = rsm__buffers_check(&log, buffers);
    if (result != RSM_OK) return result;
    if (!rsm__check_face(&log, face, map->faces)) return RSM_ERR_ARGUMENT;
    if (map->finished) return rsm__refuse(&log, RSM_ERR_ORDER, "map", "is finished");
    f.map = map;
    f.face = face;
    f.buffers = buffers;
    for (i = 0; i < 256; i++) f.srgb[i] = rsm__from_srgb((uint8_t)i);
    if (rsm__run_steps(&map->desc.system, map->side, rsm__fill_row, &f, 0.0f, 1.0f)) return RSM_OK;
    texels = (size_t)map->side * map->side;
    for (i = 0; i < texels; i++) rsm__texel_clear(map->texels + face * texels + i);
    return rsm__refuse(&log, RSM_ERR_CANCELLED, "progress", "cancelled the call");
}

/* ==== src/rsm/raster.h ==== */

/* ---- raster: triangles into a face ---- */

/* Triangles are drawn by homogeneous edge functions (Olano and Greer 1997). A corner is (x, y, w), where w is
   the depth in a perspective face and 1 for a sun. The ray (X, Y, 1) meets the triangle if three determinants
   have the same sign, and their shares are the weights of the corners. Nothing has to be clipped. Both
   triangles at an edge compute it in double from the same floats, so that there are no cracks. */
typedef struct rsm__corner {
    double x, y, w, z;
} rsm__corner;

/* Columns x0..x1 and rows y0..y1 of a face, ends included; x0 > x1 if there are none. */
typedef struct rsm__box { uint16_t x0, y0, x1, y1; } rsm__box;

typedef struct rsm__raster {
    rsm_map        *map;
    const rsm_mesh *meshes;
    size_t          mesh_count, triangles;
    uint32_t        face;
    rsm__box       *boxes;         /* of each triangle on this face */
    uint32_t       *winners;       /* for each texel the number + 1 of the triangle that is nearest; 0: none
                                      */
    rsm__v3         right, up, axis;    /* of this face */
} rsm__raster;

enum {
    RSM__CHUNK = 4096,             /* triangles whose boxes one task finds */
    RSM__BAND = 16                 /* rows of a face that one task draws */
};

static inline size_t rsm__mesh_triangles(const rsm_mesh *m)
{
    return (m->indices || m->indices16 ? m->index_count : m->vertex_count) / 3;
}

/* Returns corner k of a triangle, in the world. */
static inline rsm__v3 rsm__mesh_corner(const rsm_mesh *m, size_t triangle, int k)
{
    size_t i = 3 * triangle + (size_t)k;
    const float *p, *t = m->transform;
    if (m->indices) i = m->indices[i];
    else if (m->indices16) i = m->indices16[i];
    p = rsm__element_at(m->positions, rsm__stride_or(m->vertex_stride, 12), i);
    if (!t) return rsm__v3_load(p);
    return rsm__v3_make(t[0] * p[0] + t[4] * p[1] + t[8] * p[2] + t[12],
                        t[1] * p[0] + t[5] * p[1] + t[9] * p[2] + t[13],
                        t[2] * p[0] + t[6] * p[1] + t[10] * p[2] + t[14]);
}

/* Returns the mesh that holds triangle `number` of all meshes, and writes its number within the mesh. */
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

static inline void rsm__widen_box(double box[4], double x, double y)
{
    if (x < box[0]) box[0] = x;
    if (y < box[1]) box[1] = y;
    if (x > box[2]) box[2] = x;
    if (y > box[3]) box[3] = y;
}

/* Returns the box of texels whose centres may lie in the triangle. In place of a corner before the near plane
   count the points where the corner's edges cross that plane. */
static inline rsm__box rsm__bound_triangle(const rsm__raster *r, const rsm__corner c[3])
{
    double box[4] = { 1e30, 1e30, -1e30, -1e30 }, near_z = (double)r->map->desc.light.near_depth,
           size = r->map->side;
    rsm__box out = { 1, 0, 0, 0 };
    int k;
    if (rsm__is_sun(r->map)) {
        for (k = 0; k < 3; k++) rsm__widen_box(box, c[k].x, c[k].y);
    } else
        for (k = 0; k < 3; k++) {
            const rsm__corner *p = &c[k], *q = &c[(k + 1) % 3];
            if (p->z >= near_z) rsm__widen_box(box, p->x / p->w, p->y / p->w);
            if ((p->z >= near_z) != (q->z >= near_z)) {
                double t = (near_z - p->z) / (q->z - p->z), w = near_z * (double)r->map->extent;
                rsm__widen_box(box, (p->x + t * (q->x - p->x)) / w, (p->y + t * (q->y - p->y)) / w);
            }
        }
    for (k = 0; k < 4; k++) { /* a hair wider than the triangle, since the edge functions decide */
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

/* Returns whether a triangle is drawn: its corners are usable and it has an area. */
static inline int rsm__corners_usable(const rsm__v3 p[3])
{
    rsm__v3 n = rsm__v3_cross(rsm__v3_sub(p[1], p[0]), rsm__v3_sub(p[2], p[0]));
    return rsm__is_usable(p[0]) && rsm__is_usable(p[1]) && rsm__is_usable(p[2]) &&
           (n.x != 0.0f || n.y != 0.0f || n.z != 0.0f);
}

/* Finds the boxes of a chunk of triangles. */
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
        r->boxes[i] = rsm__bound_triangle(r, c);
    }
}

/* The edge functions of a triangle. Edge k at (x, y) is a[k] x + b[k] y + c[k], which is above 0 inside;
   points on the edge are inside if it is owned. */
typedef struct rsm__edges { double a[3], b[3], c[3], determinant; int owned[3]; } rsm__edges;

/* Makes the edge functions. Returns 0 for a triangle that is seen edge-on. */
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

/* Writes the weights of the corners at (x, y). Returns 0 if that lies outside of the triangle. */
static inline int rsm__find_weights(const rsm__edges *e, double x, double y, double w[3])
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

/* Returns whether the mesh's mask has a hole there. */
static inline int rsm__is_hole(const rsm_mesh *m, size_t triangle, const double w[3])
{
    float weights[3] = { (float)w[0], (float)w[1], (float)w[2] };
    return m->mask_fn && !m->mask_fn(m->user, (uint32_t)triangle, weights);
}

/* Draws one triangle into the rows y0..y1 of the face: where it is nearest, its depth goes into the texel and
   its number among the winners. */
static inline void rsm__draw_triangle(const rsm__raster *r, const rsm_mesh *m, size_t triangle, size_t number,
                                      uint32_t y0, uint32_t y1)
{
    rsm__box box = r->boxes[number];
    double size = r->map->side, low = (double)r->map->desc.light.near_depth,
           high = (double)r->map->desc.light.far_depth;
    rsm__corner c[3];
    rsm__edges e;
    uint32_t x, y;
    int k;
    for (k = 0; k < 3; k++) c[k] = rsm__project_corner(r, rsm__mesh_corner(m, triangle, k));
    if (!rsm__edges_make(&e, c)) return;
    for (y = box.y0 > y0 ? box.y0 : y0; y <= box.y1 && y <= y1; y++)
        for (x = box.x0; x <= box.x1; x++) {
            size_t at = ((size_t)r->face * r->map->side + y) * r->map->side + x;
            double w[3], z;
            if (!rsm__find_weights(&e, (x + 0.5) * 2.0 / size - 1.0, (y + 0.5) * 2.0 / size - 1.0, w))
                continue;
            z = w[0] * c[0].z + w[1] * c[1].z + w[2] * c[2].z;
            if (!(z >= low && z <= high && (float)z < r->map->texels[at].depth) ||
                rsm__is_hole(m, triangle, w))
                continue;
            r->map->texels[at].depth = (float)z;
            r->winners[(size_t)y * r->map->side + x] = (uint32_t)number + 1u;
        }
}

/* Writes the mean of surface_fn over those of taps x taps points of the texel, in the triangle's plane, that
   are in no hole. */
static inline void rsm__mean_albedo(const rsm_mesh *m, size_t triangle, const rsm__edges *e, double x,
                                    double y, double h, float out[3])
{
    uint32_t taps = m->tap_side ? m->tap_side : 1, i, j, found = 0;
    float sum[3] = { 0, 0, 0 };
    int k;
    for (k = 0; k < 3; k++) out[k] = m->albedo[k];
    if (!m->surface_fn) return;
    for (j = 0; j < taps; j++)
        for (i = 0; i < taps; i++) {
            double s = x + h * ((2.0 * i + 1.0) / taps - 1.0), t = y + h * ((2.0 * j + 1.0) / taps - 1.0),
                   total = 0.0, w[3];
            float weights[3], albedo[3] = { 0, 0, 0 };
            for (k = 0; k < 3; k++) {
                w[k] = e->a[k] * s + e->b[k] * t + e->c[k];
                w[k] = w[k] > 0.0 ? w[k] : 0.0; /* a point beyond an edge is moved onto the edge */
                total += w[k];
            }
            for (k = 0; k < 3; k++) weights[k] = total > 0.0 ? (float)(w[k] / total) : 1.0f / 3.0f;
            if (m->mask_fn && !m->mask_fn(m->user, (uint32_t)triangle, weights)) continue;
            m->surface_fn(m->user, m, (uint32_t)triangle, weights, albedo);
            for (k = 0; k < 3; k++) sum[k] += albedo[k];
            found++;
        }
    for (k = 0; k < 3; k++) out[k] = found ? sum[k] / (float)found : 0.0f;
}

/* Fills in a texel of the triangle that won it. */
static inline void rsm__resolve_texel(const rsm__raster *r, uint32_t x, uint32_t y)
{
    uint32_t winner = r->winners[(size_t)y * r->map->side + x];
    double size = r->map->side, s = (x + 0.5) * 2.0 / size - 1.0, t = (y + 0.5) * 2.0 / size - 1.0, w[3];
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
    if (!rsm__find_weights(&e, s, t, w)) return;
    normal = rsm__v3_normalize(rsm__v3_cross(rsm__v3_sub(p[1], p[0]), rsm__v3_sub(p[2], p[0])));
    position = rsm__v3_make((float)(w[0] * (double)p[0].x + w[1] * (double)p[1].x + w[2] * (double)p[2].x),
                            (float)(w[0] * (double)p[0].y + w[1] * (double)p[1].y + w[2] * (double)p[2].y),
                            (float)(w[0] * (double)p[0].z + w[1] * (double)p[1].z + w[2] * (double)p[2].z));
    if (rsm__v3_dot(normal, rsm__to_light(r->map, position)) < 0.0f) normal = rsm__v3_scale(normal, -1);
    rsm__mean_albedo(m, triangle, &e, s, t, 1.0 / size, albedo);
    rsm__texel_set(r->map, r->face, x, y, position, normal, albedo, m->material);
}

/* Draws all triangles into a band of rows, and fills in its texels. */
static inline void rsm__draw_band(void *context, size_t band)
{
    const rsm__raster *r = (const rsm__raster *)context;
    uint32_t y0 = (uint32_t)band * RSM__BAND, y1 = y0 + RSM__BAND - 1u, x, y;
    size_t number = 0, triangle, mesh;
    if (y1 >= r->map->side) y1 = r->map->side - 1u;
    for (mesh = 0; mesh < r->mesh_count; mesh++)
        for (triangle = 0; triangle < rsm__mesh_triangles(r->meshes + mesh); triangle++, number++) {
            rsm__box b = r->boxes[number];
            if (b.x0 <= b.x1 && b.y0 <= y1 && b.y1 >= y0)
                rsm__draw_triangle(r, r->meshes + mesh, triangle, number, y0, y1);
        }
    for (y = y0; y <= y1; y++)
        for (x = 0; x < r->map->side; x++) rsm__resolve_texel(r, x, y);
}

/* Writes the name of a mesh's field for the log, as in "meshes[2].positions". */
static inline const char *rsm__mesh_field(rsm__message *name, size_t number, const char *field)
{
    name->used = 0;
    rsm__message_text(name, "meshes[");
    rsm__message_count(name, number);
    rsm__message_text(name, "]");
    rsm__message_text(name, field);
    return name->text;
}

/* Logs that a field of a mesh is out of its range, and returns the result. */
static inline rsm_result rsm__refuse_mesh(const rsm__logger *log, rsm_result result, size_t number,
                                          const char *field, double value, const char *wanted)
{
    rsm__message name;
    rsm__log_value(log, rsm__mesh_field(&name, number, field), value, wanted);
    return result;
}

/* Logs that a field of a mesh is what the text says, and returns the result. */
static inline rsm_result rsm__refuse_mesh_text(const rsm__logger *log, rsm_result result, size_t number,
                                               const char *field, const char *text)
{
    rsm__message name;
    rsm__log_text(log, rsm__mesh_field(&name, number, field), text);
    return result;
}

/* Checks what must hold before the arrays of a mesh can be read. */
static inline rsm_result rsm__arrays_check(const rsm__logger *log, const rsm_mesh *m, size_t number)
{
    const int indexed = m->indices || m->indices16;
    size_t count = indexed ? m->index_count : m->vertex_count;
    if (!m->positions && m->vertex_count)
        return rsm__refuse_mesh_text(log, RSM_ERR_ARGUMENT, number, ".positions", "is NULL");
    if (!rsm__stride_valid(m->vertex_stride, 12))
        return rsm__refuse_mesh(log, RSM_ERR_ARGUMENT, number, ".vertex_stride", (double)m->vertex_stride,
                                "0 or a multiple of 4 from 12 on");
    if (m->indices && m->indices16)
        return rsm__refuse_mesh_text(log, RSM_ERR_ARGUMENT, number, ".indices16", "is set beside indices");
    if (count % 3 != 0)
        return rsm__refuse_mesh(log, RSM_ERR_ARGUMENT, number, indexed ? ".index_count" : ".vertex_count",
                                (double)count, "a multiple of 3");
    return RSM_OK;
}

static inline rsm_result rsm__indices_check(const rsm__logger *log, const rsm_mesh *m, size_t number)
{
    const int indexed = m->indices || m->indices16;
    size_t k, count = indexed ? m->index_count : m->vertex_count;
    rsm__message name;
    for (k = 0; indexed && k < count; k++) {
        uint32_t index = m->indices ? m->indices[k] : m->indices16[k];
        if (index < m->vertex_count) continue;
        rsm__log_index(log, rsm__mesh_field(&name, number, ""), k, index, m->vertex_count);
        return RSM_ERR_INPUT;
    }
    return RSM_OK;
}

static inline rsm_result rsm__mesh_check(const rsm__logger *log, const rsm_mesh *m, size_t number)
{
    const rsm_result result = rsm__arrays_check(log, m, number);
    int k;
    if (result != RSM_OK) return result;
    if (m->tap_side > 16)
        return rsm__refuse_mesh(log, RSM_ERR_INPUT, number, ".tap_side", m->tap_side, "0..16");
    for (k = 0; k < 3; k++)
        if (!(m->albedo[k] >= 0.0f && m->albedo[k] <= 1e6f))
            return rsm__refuse_mesh(log, RSM_ERR_INPUT, number, ".albedo", (double)m->albedo[k], "0..1e6");
    for (k = 0; m->transform && k < 16; k++)
        if (!rsm__finite(m->transform[k]))
            return rsm__refuse_mesh(log, RSM_ERR_INPUT, number, ".transform", (double)m->transform[k],
                                    "finite");
    return rsm__indices_check(log, m, number);
}

/* Checks all meshes, and counts their triangles and those that are skipped. */
static inline rsm_result rsm__meshes_check(const rsm__logger *log, rsm__raster *r, uint64_t *skipped)
{
    size_t i, triangle;
    int k;
    r->triangles = 0;
    for (i = 0; i < r->mesh_count; i++) {
        const rsm_mesh *m = r->meshes + i;
        size_t count = rsm__mesh_triangles(m);
        rsm_result result = rsm__mesh_check(log, m, i);
        if (result != RSM_OK) return result;
        if (count > 0xfffffffeu - r->triangles) {
            rsm__log_value(log, "the triangles of meshes", (double)r->triangles + (double)count,
                           "below 2^32 - 1");
            return RSM_ERR_LIMIT;
        }
        r->triangles += count;
        for (triangle = 0; triangle < count; triangle++) {
            rsm__v3 p[3];
            for (k = 0; k < 3; k++) p[k] = rsm__mesh_corner(m, triangle, k);
            *skipped += !rsm__corners_usable(p);
        }
    }
    return RSM_OK;
}

static inline rsm_result rsm__raster_faces(rsm__raster *r)
{
    const rsm_system *s = &r->map->desc.system;
    size_t texels = (size_t)r->map->side * r->map->side;
    float share = 1.0f / (float)r->map->faces;
    for (r->face = 0; r->face < r->map->faces; r->face++) {
        rsm__face_frame(r->map, r->face, &r->right, &r->up, &r->axis);
        memset(r->winners, 0, texels * sizeof *r->winners);
        rsm__run_tasks(s, (r->triangles + RSM__CHUNK - 1) / RSM__CHUNK, rsm__bound_chunk, r);
        if (!rsm__run_steps(s, (r->map->side + RSM__BAND - 1) / RSM__BAND, rsm__draw_band, r,
                            share * (float)r->face, share * (float)(r->face + 1)))
            return RSM_ERR_CANCELLED;
    }
    return RSM_OK;
}

RSM_DEF rsm_result rsm_rasterize(rsm_map *map, const rsm_mesh *meshes, size_t mesh_count)
{
    rsm__logger log = rsm__logger_of(map ? &map->desc.system : NULL, "rsm_rasterize");
    rsm__raster r;
    rsm__allocator a;
    rsm_result result;
    uint64_t skipped = 0;
    size_t i, texels;
    if (!map) return RSM_ERR_ARGUMENT;
    if (!meshes && mesh_count) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "meshes", "is NULL");
    if (map->finished) return rsm__refuse(&log, RSM_ERR_ORDER, "map", "is finished");
    memset(&r, 0, sizeof r);
    r.map = map;
    r.meshes = meshes;
    r.mesh_count = mesh_count;
    result = rsm__meshes_check(&log, &r, &skipped);
    if (result != RSM_OK) return result;
    a = rsm__allocator_of(&map->desc.system);
    texels = rsm__texel_count(map);
    r.boxes = (rsm__box *)rsm__alloc_array(&a, r.triangles + 1, sizeof *r.boxes);
    r.winners = (uint32_t *)rsm__alloc_array(&a, (size_t)map->side * map->side, sizeof *r.winners);
    for (i = 0; i < texels; i++) rsm__texel_clear(map->texels + i);
    result = r.boxes && r.winners ? rsm__raster_faces(&r) : RSM_ERR_ALLOC;
    for (i = 0; i < texels && result != RSM_OK; i++) rsm__texel_clear(map->texels + i);
    if (result == RSM_ERR_ALLOC)
        rsm__log_text(&log, "the allocator", "returned no memory for boxes of triangles");
    if (result == RSM_ERR_CANCELLED) rsm__log_text(&log, "progress", "cancelled the call");
    if (result == RSM_OK) map->stats.skipped_triangles = skipped;
    rsm__free(&a, r.winners);
    rsm__free(&a, r.boxes);
    return result;
}

/* ==== src/rsm/keeping.h ==== */

/* ---- keeping: maps whose light and meshes are what they were ---- */

enum { RSM__READ = 32768 };        /* rows of an array that one task reads */

typedef struct rsm__rows {         /* rows of an array of a mesh, and the number that their bytes make */
    const void *base;
    size_t      stride, each;      /* bytes from one row to the next, and those of a row that count */
    size_t      count;
    uint64_t    key;
} rsm__rows;

/* Returns a number that is another one for another word, and, if the words are the same, for another key: so
   one word that differs always makes another key, and several that do miss it once in 2^64. */
static inline uint64_t rsm__key_with(uint64_t key, uint64_t word)
{
    key = (key ^ word) * 0x9e3779b97f4a7c15u;
    return key ^ key >> 32;
}

/* Returns the key of bytes, after one that is given. Four keys run side by side, since each waits for its
   product. */
static inline uint64_t rsm__key_of_bytes(uint64_t key, const void *data, size_t bytes)
{
    const char *at = (const char *)data;
    uint64_t lanes[4], words[4];
    int k;
    for (k = 0; k < 4; k++) lanes[k] = key + (uint64_t)k;
    key = rsm__key_with(key, bytes);
    while (bytes) {
        size_t some = bytes < sizeof words ? bytes : sizeof words;
        if (some < sizeof words) memset(words, 0, sizeof words);
        memcpy(words, at, some);
        for (k = 0; k < 4; k++) lanes[k] = rsm__key_with(lanes[k], words[k]);
        at += some;
        bytes -= some;
    }
    for (k = 0; k < 4; k++) key = rsm__key_with(key, lanes[k]);
    return key;
}

/* Finds the key of some rows; rows that do not lie one right after the other are put so first. */
static inline void rsm__read_rows(void *context, size_t index)
{
    rsm__rows *r = (rsm__rows *)context + index;
    const char *at = (const char *)r->base;
    float row[64 * 3];
    size_t i, n;
    r->key = 0;
    if (r->stride == r->each) r->key = rsm__key_of_bytes(0, at, r->count * r->each);
    for (; r->stride != r->each && r->count; r->count -= n) { /* the rows of vertices, of 12 bytes */
        n = r->count < 64 ? r->count : (size_t)64;
        for (i = 0; i < n; i++, at += r->stride) memcpy(row + 3 * i, at, r->each);
        r->key = rsm__key_of_bytes(r->key, row, n * r->each);
    }
}

/* Cuts an array into pieces that tasks read. Writes none if `out` is NULL; returns how many there are. */
static inline size_t rsm__cut_rows(rsm__rows *out, const void *base, size_t stride, size_t each, size_t count)
{
    size_t pieces = count / RSM__READ + (count % RSM__READ != 0), i;
    for (i = 0; out && i < pieces; i++) {
        out[i].base = (const char *)base + i * RSM__READ * stride;
        out[i].stride = stride;
        out[i].each = each;
        out[i].count = i + 1 < pieces ? (size_t)RSM__READ : count - i * RSM__READ;
    }
    return pieces;
}

/* Cuts the arrays of all meshes into pieces. Returns how many there are. */
static inline size_t rsm__cut_meshes(rsm__rows *out, const rsm_mesh *meshes, size_t mesh_count)
{
    size_t i, n = 0;
    for (i = 0; i < mesh_count; i++) {
        const rsm_mesh *m = meshes + i;
        n += rsm__cut_rows(out ? out + n : NULL, m->positions, rsm__stride_or(m->vertex_stride, 12), 12,
                           m->vertex_count);
        if (m->indices) n += rsm__cut_rows(out ? out + n : NULL, m->indices, 4, 4, m->index_count);
        if (m->indices16) n += rsm__cut_rows(out ? out + n : NULL, m->indices16, 2, 2, m->index_count);
    }
    return n;
}

/* Returns the key of what a mesh says beside its arrays. What its functions say has version for a key. */
static inline uint64_t rsm__key_of_fields(uint64_t key, const rsm_mesh *m)
{
    const int has_indices = m->indices != NULL, has_indices16 = m->indices16 != NULL;
    const int functions = (m->mask_fn != NULL) + 2 * (m->surface_fn != NULL);
    key = rsm__key_with(key, m->vertex_count);
    key = rsm__key_with(key, has_indices || has_indices16 ? m->index_count : 0);
    key = rsm__key_with(key, (uint64_t)(has_indices + 2 * has_indices16 + 4 * functions));
    key = rsm__key_with(key, functions ? m->version : 0);
    key = rsm__key_with(key, (uint64_t)m->material << 32 | m->tap_side);
    key = rsm__key_of_bytes(key, m->albedo, sizeof m->albedo);
    return rsm__key_of_bytes(key, m->transform, m->transform ? 16 * sizeof(float) : 0);
}

/* Finds the key of all that a map is drawn from: 0 if functions may say anything. */
static inline rsm_result rsm__find_key(const rsm__logger *log, const rsm_map *map, const rsm_light *light,
                                       const rsm_mesh *meshes, size_t mesh_count, uint64_t *out)
{
    rsm__allocator a = rsm__allocator_of(&map->desc.system);
    uint64_t key = rsm__key_of_bytes(1, light, sizeof *light);
    rsm__rows *rows;
    size_t i, n;
    *out = 0;
    for (i = 0; i < mesh_count; i++) {
        const rsm_mesh *m = meshes + i;
        rsm_result result = rsm__arrays_check(log, m, i);
        if (result != RSM_OK) return result;
        if ((m->mask_fn || m->surface_fn) && m->version == 0) return RSM_OK;
        key = rsm__key_of_fields(key, m);
    }
    n = rsm__cut_meshes(NULL, meshes, mesh_count);
    rows = (rsm__rows *)rsm__alloc_array(&a, n + 1, sizeof *rows);
    if (!rows) return rsm__refuse(log, RSM_ERR_ALLOC, "the allocator", "returned no memory for keys");
    rsm__cut_meshes(rows, meshes, mesh_count);
    rsm__run_tasks(&map->desc.system, n, rsm__read_rows, rows);
    for (i = 0; i < n; i++) key = rsm__key_with(key, rows[i].key);
    rsm__free(&a, rows);
    *out = key ? key : 1;
    return RSM_OK;
}

RSM_DEF rsm_result rsm_redraw(rsm_map *map, const rsm_light *light, const rsm_mesh *meshes, size_t mesh_count,
                              int *kept, rsm_stats *stats)
{
    rsm__logger log = rsm__logger_of(map ? &map->desc.system : NULL, "rsm_redraw");
    rsm_light now;
    uint64_t key;
    rsm_stats own;
    rsm_result result;
    int same;
    if (!map) return RSM_ERR_ARGUMENT;
    if (!meshes && mesh_count) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "meshes", "is NULL");
    now = light ? *light : map->desc.light;
    result = rsm__light_check(&log, &now);
    if (result == RSM_OK) result = rsm__find_key(&log, map, &now, meshes, mesh_count, &key);
    if (result != RSM_OK) return result;
    same = key && map->finished && map->key == key;
    if (!same) {
        result = rsm_map_restart(map, &now);
        if (result == RSM_OK) result = rsm_rasterize(map, meshes, mesh_count);
        if (result == RSM_OK) result = rsm_finish(map, &own);
        if (result != RSM_OK) return result;
        map->key = key;
    }
    if (kept) *kept = same;
    if (stats) *stats = map->stats;
    return RSM_OK;
}

/* ==== src/rsm/patterns.h ==== */

/* ---- patterns: samples of the unit disc (equation 3), and blue noise ---- */

/* Writes a sample of the unit disc: its place at a radius and a share of a full turn, and its weight. */
static inline void rsm__disc_point(float *out, float radius, float turn, float weight)
{
    float s, c;
    rsm__sincos(turn * (2.0f * RSM__PI), &s, &c);
    out[0] = radius * c;
    out[1] = radius * s;
    out[2] = weight;
}

/* Makes a Poisson pattern by throwing darts on a torus that is twice the disc's radius wide. A dart must keep
   a least distance from all others; this is lowered whenever 100 darts in a row do not, so that every pattern
   is finished. No place of the torus differs from another, so that the disc is covered evenly up to its rim.
   Darts thrown at the disc alone would crowd at the rim (4 % too dark in T25 with 400). */
static inline void rsm__make_poisson(uint32_t count, uint32_t seed, float *out)
{
    /* Pairs from the front are points of the disc, pairs from the back (27 % as many) those in the square's
       corners. */
    float least = 1.5f / sqrtf((float)count);
    uint32_t found = 0, outside = 0, tries = 0;
    uint32_t dart, i;
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

/* Makes a pattern of density C / r^2 outside of an inner disc and C / r_min^2 inside. Ring and disc are two
   strata, each with its share of the samples. A stratum is a lattice, with radii at even steps and angles by
   the golden ratio, which is even for any number of samples. */
static inline void rsm__make_log_radial(uint32_t count, float r_min, uint32_t seed, float *out)
{
    float length = -rsm__log(r_min), u, v, r;
    uint32_t inner = (uint32_t)((float)count / (1.0f + 2.0f * length) + 0.5f), i;
    if (inner < 1) inner = 1;
    if (inner >= count) inner = count - 1;
    for (i = 0; i < count; i++) {
        uint32_t k = i < inner ? i : i - inner, n = i < inner ? inner : count - inner;
        u = ((float)k + rsm__random(seed, 8, i < inner)) / (float)n;
        v = rsm__fraction(rsm__to_unit(k * 2654435769u) + rsm__random(seed, 9, i < inner));
        if (i < inner)
            rsm__disc_point(out + 3 * i, r_min * sqrtf(u), v, RSM__PI * r_min * r_min / (float)inner);
        else {
            r = rsm__exp(-length * (1.0f - u));
            rsm__disc_point(out + 3 * i, r, v, 2.0f * RSM__PI * r * r * length / (float)(count - inner));
        }
    }
}

/* Makes a pattern about the receiver. With `paper`, samples of EQUATION3 have the paper's weights. */
static inline void rsm__pattern_make(rsm_pattern pattern, uint32_t count, float r_min, int paper,
                                     uint32_t seed, float *out)
{
    float u, v;
    double sum = 0.0;
    uint32_t i;
    if (pattern == RSM_PATTERN_POISSON) rsm__make_poisson(count, seed, out);
    else if (pattern == RSM_PATTERN_LOG_RADIAL && count > 1) rsm__make_log_radial(count, r_min, seed, out);
    else
        for (i = 0; i < count; i++) {
            rsm__sobol2(i, seed, &u, &v);
            if (pattern == RSM_PATTERN_EQUATION3)
                rsm__disc_point(out + 3 * i, u, v, 2.0f * RSM__PI * u / (float)count);
            else rsm__disc_point(out + 3 * i, sqrtf(u), v, RSM__PI / (float)count);
        }
    if (!paper || pattern != RSM_PATTERN_EQUATION3) return;
    for (i = 0; i < count; i++) sum += (double)(out[3 * i] * out[3 * i] + out[3 * i + 1] * out[3 * i + 1]);
    for (i = 0; i < count && sum > 0.0; i++)
        out[3 * i + 2] =
            (float)(3.14159265358979 / sum) * (out[3 * i] * out[3 * i] + out[3 * i + 1] * out[3 * i + 1]);
}

RSM_DEF rsm_result rsm_pattern_build(rsm_pattern pattern, uint32_t sample_count, float r_min,
                                     int paper_weights, uint32_t seed, float *points)
{
    if (!points || sample_count == 0 || sample_count > RSM__MAX_SAMPLES || !(r_min >= 0.0f && r_min < 1.0f))
        return RSM_ERR_ARGUMENT;
    if ((int)pattern <= RSM_PATTERN_FLUX || pattern >= RSM_PATTERN_MIXED) return RSM_ERR_ARGUMENT;
    if (pattern == RSM_PATTERN_POISSON && sample_count > RSM__MAX_POISSON) return RSM_ERR_ARGUMENT;
    rsm__pattern_make(pattern, sample_count, r_min > 0.0f ? r_min : 1.0f / 32.0f, paper_weights, seed,
                      points);
    return RSM_OK;
}

/* Adds the energy of a set pixel to the pixels about it, round the borders: a Gaussian of sigma 1.9, where
   Ulichney says 1.5 to 2. A sign of -1 takes the energy away. */
static inline void rsm__splat_energy(float *energy, uint32_t side, uint32_t at, float sign)
{
    int32_t reach = side > 20 ? 10 : ((int32_t)side - 1) / 2, i, j;
    for (j = -reach; j <= reach; j++)
        for (i = -reach; i <= reach; i++) {
            uint32_t x = (at % side + side + (uint32_t)i) % side, y = (at / side + side + (uint32_t)j) % side;
            energy[y * side + x] += sign * rsm__exp((float)(i * i + j * j) * -0.1385f);
        }
}

/* Returns the pixel in the tightest cluster among set pixels, or, without `set`, the pixel in the largest
   void among those that are not. A pixel is set if its mark is above 0. */
static inline uint32_t rsm__find_extreme(const float *energy, const float *marks, uint32_t count, int set)
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

/* Writes blue noise to marks, by void and cluster (Ulichney 1993). energy is scratch. While the ranks are
   found, the mark of a pixel is 0 (not set), 0.5 (set, with a rank that is not known yet), or its rank + 1.
   */
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
    for (k = 0; k < count; k++) { /* spread them evenly: the pixel in the tightest cluster goes into the
                                     largest void, until it comes back to where it was */
        uint32_t from = rsm__find_extreme(energy, marks, count, 1), to;
        marks[from] = 0.0f;
        rsm__splat_energy(energy, side, from, -1.0f);
        to = rsm__find_extreme(energy, marks, count, 0);
        marks[to] = 1.0f;
        rsm__splat_energy(energy, side, to, 1.0f);
        if (to == from) break;
    }
    for (i = 0; i < count; i++)
        if (marks[i] > 0.0f) marks[i] = 0.5f;
    for (k = first; k-- > 0;) { /* ranks of these: the pixel in the tightest cluster is taken away first, and
                                   those that are left have 0.5 */
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
        uint32_t at = rsm__find_extreme(energy, marks, count, 0);
        marks[at] = (float)k + 1.0f;
        rsm__splat_energy(energy, side, at, 1.0f);
    }
    for (i = 0; i < count; i++) marks[i] = (marks[i] - 0.5f) / (float)count;
}

RSM_DEF rsm_result rsm_blue_noise(uint32_t side, uint32_t seed, const rsm_system *system, float *values)
{
    rsm__logger log = rsm__logger_of(system, "rsm_blue_noise");
    rsm_system none;
    rsm__allocator a;
    float *energy;
    memset(&none, 0, sizeof none);
    if (!system) system = &none;
    if (!values) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "values", "is NULL");
    if (!rsm__check_range(&log, "side", side, 4, 64, "4..64")) return RSM_ERR_ARGUMENT;
    if (!rsm__system_valid(&log, system)) return RSM_ERR_DESC;
    a = rsm__allocator_of(system);
    energy = (float *)rsm__alloc_array(&a, (size_t)side * side, sizeof *energy);
    if (!energy) return rsm__refuse(&log, RSM_ERR_ALLOC, "the allocator", "returned no memory");
    rsm__void_and_cluster(side, seed, energy, values);
    rsm__free(&a, energy);
    return RSM_OK;
}

/* ==== src/rsm/kernel.h ==== */

/* ---- kernel: pixel lights on one receiver, or on as many as lanes ---- */

/* Returns by how much rounding may move a point at (x, y, z) off its plane: 4e-7 of its largest coordinate. A
   light counts only if it stands out of the receiver's plane, and the receiver out of the light's, by more
   than that, so that a plane does not light itself. Each light has its own bound. One for the whole map, by
   its farthest texel, would take away the light between near surfaces if there is a sky dome far off. */
static inline float rsm__rounding(float x, float y, float z)
{
    float most = fabsf(x) > fabsf(y) ? fabsf(x) : fabsf(y);
    return 4e-7f * (most > fabsf(z) ? most : fabsf(z));
}

/* A block of pixel lights, each in a lane of arrays that vectors read. A lane that is not in use has no flux.
   */
typedef struct rsm__block {
    float px[RSM__BLOCK], py[RSM__BLOCK], pz[RSM__BLOCK];    /* where each light is */
    float nx[RSM__BLOCK], ny[RSM__BLOCK], nz[RSM__BLOCK];    /* its normal */
    float r[RSM__BLOCK], g[RSM__BLOCK], b[RSM__BLOCK];       /* its flux */
    float cap[RSM__BLOCK];         /* the bound on cos cos / d^2 */
    float rounding[RSM__BLOCK];    /* rsm__rounding of its position */
    float lx[RSM__BLOCK], ly[RSM__BLOCK], lz[RSM__BLOCK];    /* with MIXED the light's place in the map
                                                                (centred.h); with a near field lx is the face
                                                                that its texel lies in */
    float density[RSM__BLOCK];     /* with MIXED the density with which the light was picked; with a near
                                      field the squared distance within which its texel is near */
} rsm__block;

typedef struct rsm__gloss {        /* a light's Phong lobe */
    float mirror[3], exponent;
    float scale[3];                /* pi x intensity of the lobe, along its axis */
} rsm__gloss;

typedef struct rsm__sum {          /* what one receiver has got so far */
    float rgb[3];
    float full, lost;              /* the light without bounds, and what the bounds took of it; kernels named
                                      lossy sum them, others leave them */
    float nearby;                  /* 1 / squared distance of the nearest light that is not edge-on; kernels
                                      named near find it */
} rsm__sum;

#define RSM__NO_CAP 3.0e38f        /* the bound of a light without one */

/* As many receivers as a vector has lanes. A few lights are taken one by one, each for all of these
   receivers. */
typedef struct rsm__receiver_lanes {
    float  x[7][RSM__WIDE];        /* positions, normals, roundings; a lane without a normal gets no light */
    float  sums[5][RSM__WIDE];     /* red, green, blue; full and lost, as in rsm__sum */
    size_t at[RSM__WIDE], count;   /* the numbers of the receivers, and how many there are */
} rsm__receiver_lanes;

typedef void (*rsm__receiver_lanes_kernel)(const rsm__block *k, size_t count, rsm__receiver_lanes *p);

/* Adds the light of `count` lanes, a multiple of RSM__LANES, of the blocks from k on to the receiver's sum. x
   holds the receiver's position, normal and rounding. */
typedef void (*rsm__kernel)(const rsm__block *k, size_t count, const float x[7], rsm__sum *sum);

/* Adds the glossy part of a light towards a receiver: a Phong lobe about the mirrored direction of the light
   (section 7). If the light's texel is near, `mean` is the mean of cos cos / d^2 over the texel, and the lobe
   is evaluated at its centre; a `mean` below 0 says that the light is a point. */
static inline void rsm__add_gloss(const rsm__gloss *gloss, const rsm__block *k, size_t i, const float x[7],
                                  float mean, rsm__sum *sum)
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

/* ==== src/rsm/kernels_begin.h ==== */

/* ---- kernels: one text, compiled for every instruction set ---- */

/* Pending pixels of one cell in arrays, so that the tests of section 4 run in vectors. Cells of 8 x 8 and
   4 x 4 pixels fill these vectors; the three pending pixels of a cell of 2 x 2 fill three of eight lanes. */
enum { RSM__TILE = 128 };

typedef struct rsm__tile {
    float px[RSM__TILE], py[RSM__TILE], pz[RSM__TILE];
    float nx[RSM__TILE], ny[RSM__TILE], nz[RSM__TILE];
    int32_t  good[RSM__TILE];      /* a bit for each of the cell's samples that suits the pixel */
    uint32_t x[RSM__TILE], y[RSM__TILE];    /* of the pixel in the picture */
} rsm__tile;

/* Sets `bit` in those of a tile's pixels that a sample suits. s holds the sample's position and normal,
   limits the least cosine, the largest slope^2 and the largest distance^2. count is a multiple of 8. */
typedef void (*rsm__suit_kernel)(rsm__tile *t, size_t count, const float s[6], const float limits[3],
                                 int32_t bit);

/* Names that every instruction set has of its own, see unit simd. */
#define rsm__lights RSM__NAME_IN_SET(rsm__lights, RSM__SET)
#define rsm__receivers RSM__NAME_IN_SET(rsm__receivers, RSM__SET)
#define rsm__lights_load RSM__NAME_IN_SET(rsm__lights_load, RSM__SET)
#define rsm__light_in_all RSM__NAME_IN_SET(rsm__light_in_all, RSM__SET)
#define rsm__forms RSM__NAME_IN_SET(rsm__forms, RSM__SET)
#define rsm__forms_make RSM__NAME_IN_SET(rsm__forms_make, RSM__SET)
#define rsm__lane_sums RSM__NAME_IN_SET(rsm__lane_sums, RSM__SET)
#define rsm__sums_zero RSM__NAME_IN_SET(rsm__sums_zero, RSM__SET)
#define rsm__sums_add RSM__NAME_IN_SET(rsm__sums_add, RSM__SET)
#define rsm__sums_reduce RSM__NAME_IN_SET(rsm__sums_reduce, RSM__SET)
#define rsm__sum_blocks RSM__NAME_IN_SET(rsm__sum_blocks, RSM__SET)
#define rsm__sum_lights RSM__NAME_IN_SET(rsm__sum_lights, RSM__SET)
#define rsm__sum_lights_lossy RSM__NAME_IN_SET(rsm__sum_lights_lossy, RSM__SET)
#define rsm__sum_lights_near RSM__NAME_IN_SET(rsm__sum_lights_near, RSM__SET)
#define rsm__sum_lights_near_lossy RSM__NAME_IN_SET(rsm__sum_lights_near_lossy, RSM__SET)
#define rsm__sum_on_receivers RSM__NAME_IN_SET(rsm__sum_on_receivers, RSM__SET)
#define rsm__light_receivers RSM__NAME_IN_SET(rsm__light_receivers, RSM__SET)
#define rsm__light_receivers_lossy RSM__NAME_IN_SET(rsm__light_receivers_lossy, RSM__SET)
#define rsm__suit_tile RSM__NAME_IN_SET(rsm__suit_tile, RSM__SET)

#define RSM__SET plain
#define RSM__WIDTH RSM__SIMD_WIDTH
#define RSM__LANE_COUNT 8

#endif /* !RSM_IMPLEMENTED */

#ifdef RSM__SET
#if RSM_VERSION != 10000 /* this file's: another one that includes it as RSM_FILE has its own */
#error "rsm.h: the file that RSM_FILE names is of another version than the one that includes it"
#endif

/* ==== src/shared/simd_begin.h ==== */

/* unit simd_begin, needs simd: what the kernels of one instruction set are compiled with */

#undef RSM__KERNEL
#undef RSM__IN_KERNEL
#undef RSM__IN_LARGE_KERNEL
#undef RSM__INTEL
#undef RSM__EACH

#if RSM__WIDTH == 16
#define RSM__KERNEL RSM__TARGET_AVX512
#elif RSM__WIDTH == 8
#define RSM__KERNEL RSM__TARGET_AVX2
#else
#define RSM__KERNEL
#endif

#if RSM__WIDTH == 16
#define RSM__INTEL(name) _mm512_##name
#elif RSM__WIDTH == 8
#define RSM__INTEL(name) _mm256_##name
#else
#define RSM__INTEL(name) _mm_##name
#endif

/* RSM__IN_LARGE_KERNEL stands after `static`, before a function that a kernel calls dozens of times. Such a
   function is not inlined without optimisation, nor with gcc's sanitizers, which take minutes to build large
   functions. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define RSM__IN_KERNEL __attribute__((always_inline)) RSM__KERNEL
#else
#define RSM__IN_KERNEL RSM__KERNEL
#endif
#if defined(__GNUC__) && !defined(__TINYC__) && (!defined(__OPTIMIZE__) || defined(__SANITIZE_ADDRESS__))
#define RSM__IN_LARGE_KERNEL __attribute__((noinline)) RSM__KERNEL
#else
#define RSM__IN_LARGE_KERNEL inline RSM__IN_KERNEL
#endif

/* RSM__EACH executes statements for every piece of RSM__WIDTH lanes. The number of the piece is a constant in
   them, so that compilers keep pieces in registers. */
#if RSM__WIDTH > 1 && RSM__LANE_COUNT == RSM__WIDTH
#define RSM__EACH(...) { enum { piece = 0 }; __VA_ARGS__; }
#elif RSM__WIDTH > 1 && RSM__LANE_COUNT == 2 * RSM__WIDTH
#define RSM__EACH(...) { enum { piece = 0 }; __VA_ARGS__; } { enum { piece = 1 }; __VA_ARGS__; }
#elif RSM__WIDTH > 1 && RSM__LANE_COUNT == 4 * RSM__WIDTH
#define RSM__EACH(...) \
    { enum { piece = 0 }; __VA_ARGS__; } { enum { piece = 1 }; __VA_ARGS__; } \
    { enum { piece = 2 }; __VA_ARGS__; } { enum { piece = 3 }; __VA_ARGS__; }
#else
#define RSM__EACH(...) \
    { int piece; for (piece = 0; piece < RSM__LANE_COUNT / RSM__WIDTH; piece++) { __VA_ARGS__; } }
#endif

/* ==== src/shared/simd_x86.h ==== */

/* unit simd_x86, needs simd_begin: lanes of SSE2, AVX2 and AVX-512 */

#if RSM__SIMD_X86 || RSM__WIDTH > 4

#if RSM__WIDTH == 16
typedef struct rsm__lanes { __m512 v[RSM__LANE_COUNT / 16]; } rsm__lanes;
typedef struct rsm__lane_ints { __m512i v[RSM__LANE_COUNT / 16]; } rsm__lane_ints;
typedef struct rsm__lane_mask { __mmask16 v[RSM__LANE_COUNT / 16]; } rsm__lane_mask;
#elif RSM__WIDTH == 8
typedef struct rsm__lanes { __m256 v[RSM__LANE_COUNT / 8]; } rsm__lanes;
typedef struct rsm__lane_ints { __m256i v[RSM__LANE_COUNT / 8]; } rsm__lane_ints;
typedef struct rsm__lane_mask { __m256 v[RSM__LANE_COUNT / 8]; } rsm__lane_mask;
#else
typedef struct rsm__lanes { __m128 v[RSM__LANE_COUNT / 4]; } rsm__lanes;
typedef struct rsm__lane_ints { __m128i v[RSM__LANE_COUNT / 4]; } rsm__lane_ints;
typedef struct rsm__lane_mask { __m128 v[RSM__LANE_COUNT / 4]; } rsm__lane_mask;
#endif

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_load(const float *from)
{
    rsm__lanes a;
    RSM__EACH(a.v[piece] = RSM__INTEL(loadu_ps)(from + piece * RSM__WIDTH))
    return a;
}

static inline RSM__IN_KERNEL void rsm__lanes_store(float *to, rsm__lanes a)
{
    RSM__EACH(RSM__INTEL(storeu_ps)(to + piece * RSM__WIDTH, a.v[piece]))
}

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_all(float x)
{
    rsm__lanes a;
    RSM__EACH(a.v[piece] = RSM__INTEL(set1_ps)(x))
    return a;
}

/* Comparisons with what is not a number are false, but for differ, which is true. */
static inline RSM__IN_KERNEL rsm__lane_mask rsm__lanes_greater(rsm__lanes a, rsm__lanes b)
{
    rsm__lane_mask m;
#if RSM__WIDTH == 16
    RSM__EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_GT_OQ))
#elif RSM__WIDTH == 8
    RSM__EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_GT_OQ))
#else
    RSM__EACH(m.v[piece] = _mm_cmpgt_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

static inline RSM__IN_KERNEL rsm__lane_mask rsm__lanes_at_least(rsm__lanes a, rsm__lanes b)
{
    rsm__lane_mask m;
#if RSM__WIDTH == 16
    RSM__EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_GE_OQ))
#elif RSM__WIDTH == 8
    RSM__EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_GE_OQ))
#else
    RSM__EACH(m.v[piece] = _mm_cmpge_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

/* Returns m ? a : b in each lane. */
static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_select(rsm__lane_mask m, rsm__lanes a,
                                                 rsm__lanes b)
{
#if RSM__WIDTH == 16
    RSM__EACH(a.v[piece] = _mm512_mask_mov_ps(b.v[piece], m.v[piece], a.v[piece]))
#elif RSM__WIDTH == 8
    RSM__EACH(a.v[piece] = _mm256_blendv_ps(b.v[piece], a.v[piece], m.v[piece]))
#else
    RSM__EACH(a.v[piece] = _mm_or_ps(_mm_and_ps(m.v[piece], a.v[piece]), _mm_andnot_ps(m.v[piece], b.v[piece])))
#endif
    return a;
}

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_add(rsm__lanes a, rsm__lanes b)
{
    RSM__EACH(a.v[piece] = RSM__INTEL(add_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_sub(rsm__lanes a, rsm__lanes b)
{
    RSM__EACH(a.v[piece] = RSM__INTEL(sub_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_mul(rsm__lanes a, rsm__lanes b)
{
    RSM__EACH(a.v[piece] = RSM__INTEL(mul_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_div(rsm__lanes a, rsm__lanes b)
{
    RSM__EACH(a.v[piece] = RSM__INTEL(div_ps)(a.v[piece], b.v[piece]))
    return a;
}

/* Returns a > b ? a : b, so that b is the answer if one is not a number. */
static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_max(rsm__lanes a, rsm__lanes b)
{
#if RSM__WIDTH == 16                           /* gcc 12 warns of what max without a mask calls */
    RSM__EACH(a.v[piece] = _mm512_maskz_max_ps((__mmask16)0xffff, a.v[piece], b.v[piece]))
#else
    RSM__EACH(a.v[piece] = RSM__INTEL(max_ps)(a.v[piece], b.v[piece]))
#endif
    return a;
}

/* Returns a < b ? a : b. */
static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_min(rsm__lanes a, rsm__lanes b)
{
#if RSM__WIDTH == 16                           /* gcc 12 warns of what min without a mask calls */
    RSM__EACH(a.v[piece] = _mm512_maskz_min_ps((__mmask16)0xffff, a.v[piece], b.v[piece]))
#else
    RSM__EACH(a.v[piece] = RSM__INTEL(min_ps)(a.v[piece], b.v[piece]))
#endif
    return a;
}

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_negate(rsm__lanes a)
{
    RSM__EACH(a.v[piece] = RSM__INTEL(xor_ps)(RSM__INTEL(set1_ps)(-0.0f), a.v[piece]))
    return a;
}

/* Returns m ? a : 0. */
static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_keep(rsm__lane_mask m, rsm__lanes a)
{
#if RSM__WIDTH == 16
    RSM__EACH(a.v[piece] = _mm512_maskz_mov_ps(m.v[piece], a.v[piece]))
#else
    RSM__EACH(a.v[piece] = RSM__INTEL(and_ps)(m.v[piece], a.v[piece]))
#endif
    return a;
}

static inline RSM__IN_KERNEL rsm__lane_mask rsm__mask_and(rsm__lane_mask m, rsm__lane_mask n)
{
#if RSM__WIDTH == 16
    RSM__EACH(m.v[piece] = (__mmask16)(m.v[piece] & n.v[piece]))
#else
    RSM__EACH(m.v[piece] = RSM__INTEL(and_ps)(m.v[piece], n.v[piece]))
#endif
    return m;
}

static inline RSM__IN_KERNEL rsm__lane_ints rsm__ints_load(const int32_t *from)
{
    rsm__lane_ints k;
#if RSM__WIDTH == 16
    RSM__EACH(k.v[piece] = _mm512_loadu_si512((const void *)(from + piece * RSM__WIDTH)))
#elif RSM__WIDTH == 8
    RSM__EACH(k.v[piece] = _mm256_loadu_si256((const __m256i *)(const void *)(from + piece * RSM__WIDTH)))
#else
    RSM__EACH(k.v[piece] = _mm_loadu_si128((const __m128i *)(const void *)(from + piece * RSM__WIDTH)))
#endif
    return k;
}

static inline RSM__IN_KERNEL void rsm__ints_store(int32_t *to, rsm__lane_ints k)
{
#if RSM__WIDTH == 16
    RSM__EACH(_mm512_storeu_si512((void *)(to + piece * RSM__WIDTH), k.v[piece]))
#elif RSM__WIDTH == 8
    RSM__EACH(_mm256_storeu_si256((__m256i *)(void *)(to + piece * RSM__WIDTH), k.v[piece]))
#else
    RSM__EACH(_mm_storeu_si128((__m128i *)(void *)(to + piece * RSM__WIDTH), k.v[piece]))
#endif
}

static inline RSM__IN_KERNEL rsm__lane_ints rsm__ints_all(int32_t x)
{
    rsm__lane_ints k;
    RSM__EACH(k.v[piece] = RSM__INTEL(set1_epi32)(x))
    return k;
}

static inline RSM__IN_KERNEL rsm__lane_ints rsm__ints_or(rsm__lane_ints k, rsm__lane_ints n)
{
#if RSM__WIDTH == 16
    RSM__EACH(k.v[piece] = _mm512_or_si512(k.v[piece], n.v[piece]))
#elif RSM__WIDTH == 8
    RSM__EACH(k.v[piece] = _mm256_or_si256(k.v[piece], n.v[piece]))
#else
    RSM__EACH(k.v[piece] = _mm_or_si128(k.v[piece], n.v[piece]))
#endif
    return k;
}

/* Returns m ? k : 0. */
static inline RSM__IN_KERNEL rsm__lane_ints rsm__ints_keep(rsm__lane_mask m, rsm__lane_ints k)
{
#if RSM__WIDTH == 16
    RSM__EACH(k.v[piece] = _mm512_maskz_mov_epi32(m.v[piece], k.v[piece]))
#elif RSM__WIDTH == 8
    RSM__EACH(k.v[piece] = _mm256_and_si256(_mm256_castps_si256(m.v[piece]), k.v[piece]))
#else
    RSM__EACH(k.v[piece] = _mm_and_si128(_mm_castps_si128(m.v[piece]), k.v[piece]))
#endif
    return k;
}

#endif

/* ==== src/shared/simd_plain.h ==== */

/* unit simd_plain, needs simd_begin: lanes of NEON, WebAssembly and others, or floats one by one */

#if !RSM__SIMD_X86 && RSM__WIDTH <= 4

#if RSM__SIMD_VECTORS
typedef float rsm__piece __attribute__((vector_size(16)));
typedef int32_t rsm__piece_ints __attribute__((vector_size(16)));
typedef uint32_t rsm__piece_words __attribute__((vector_size(16)));
#else
typedef float rsm__piece;
typedef int32_t rsm__piece_ints;
typedef uint32_t rsm__piece_words;
#endif
typedef struct rsm__lanes { rsm__piece v[RSM__LANE_COUNT / RSM__WIDTH]; } rsm__lanes;
typedef struct rsm__lane_ints { rsm__piece_ints v[RSM__LANE_COUNT / RSM__WIDTH]; } rsm__lane_ints;
/* Lanes of 0 or -1. */
typedef struct rsm__lane_mask { rsm__piece_ints v[RSM__LANE_COUNT / RSM__WIDTH]; } rsm__lane_mask;

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_load(const float *from)
{
    rsm__lanes a;
    RSM__EACH(memcpy(&a.v[piece], from + piece * RSM__WIDTH, sizeof a.v[piece]))
    return a;
}

static inline RSM__IN_KERNEL void rsm__lanes_store(float *to, rsm__lanes a)
{
    RSM__EACH(memcpy(to + piece * RSM__WIDTH, &a.v[piece], sizeof a.v[piece]))
}

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_all(float x)
{
    rsm__lanes a;
#if RSM__SIMD_VECTORS
    const rsm__piece all = { x, x, x, x };
    RSM__EACH(a.v[piece] = all)
#else
    RSM__EACH(a.v[piece] = x)
#endif
    return a;
}

/* Comparisons with what is not a number are false, but for differ, which is true. */
static inline RSM__IN_KERNEL rsm__lane_mask rsm__lanes_greater(rsm__lanes a, rsm__lanes b)
{
    rsm__lane_mask m;
#if RSM__SIMD_VECTORS
    RSM__EACH(m.v[piece] = a.v[piece] > b.v[piece])
#else
    RSM__EACH(m.v[piece] = -(a.v[piece] > b.v[piece]))
#endif
    return m;
}

static inline RSM__IN_KERNEL rsm__lane_mask rsm__lanes_at_least(rsm__lanes a, rsm__lanes b)
{
    rsm__lane_mask m;
#if RSM__SIMD_VECTORS
    RSM__EACH(m.v[piece] = a.v[piece] >= b.v[piece])
#else
    RSM__EACH(m.v[piece] = -(a.v[piece] >= b.v[piece]))
#endif
    return m;
}

/* Returns m ? a : b in each lane. */
static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_select(rsm__lane_mask m, rsm__lanes a,
                                                 rsm__lanes b)
{
#if RSM__SIMD_VECTORS
    RSM__EACH(a.v[piece] = (rsm__piece)((m.v[piece] & (rsm__piece_ints)a.v[piece]) |
                                  (~m.v[piece] & (rsm__piece_ints)b.v[piece])))
#else
    RSM__EACH(a.v[piece] = m.v[piece] ? a.v[piece] : b.v[piece])
#endif
    return a;
}

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_add(rsm__lanes a, rsm__lanes b)
{
    RSM__EACH(a.v[piece] = a.v[piece] + b.v[piece])
    return a;
}

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_sub(rsm__lanes a, rsm__lanes b)
{
    RSM__EACH(a.v[piece] = a.v[piece] - b.v[piece])
    return a;
}

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_mul(rsm__lanes a, rsm__lanes b)
{
    RSM__EACH(a.v[piece] = a.v[piece] * b.v[piece])
    return a;
}

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_div(rsm__lanes a, rsm__lanes b)
{
    RSM__EACH(a.v[piece] = a.v[piece] / b.v[piece])
    return a;
}

/* Returns a > b ? a : b, so that b is the answer if one is not a number. */
static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_max(rsm__lanes a, rsm__lanes b)
{
    return rsm__lanes_select(rsm__lanes_greater(a, b), a, b);
}

/* Returns a < b ? a : b. */
static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_min(rsm__lanes a, rsm__lanes b)
{
    return rsm__lanes_select(rsm__lanes_greater(b, a), a, b);
}

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_negate(rsm__lanes a)
{
    RSM__EACH(a.v[piece] = -a.v[piece])
    return a;
}

/* Returns m ? a : 0. */
static inline RSM__IN_KERNEL rsm__lanes rsm__lanes_keep(rsm__lane_mask m, rsm__lanes a)
{
#if RSM__SIMD_VECTORS
    RSM__EACH(a.v[piece] = (rsm__piece)(m.v[piece] & (rsm__piece_ints)a.v[piece]))
#else
    RSM__EACH(a.v[piece] = m.v[piece] ? a.v[piece] : 0.0f)
#endif
    return a;
}

static inline RSM__IN_KERNEL rsm__lane_mask rsm__mask_and(rsm__lane_mask m, rsm__lane_mask n)
{
    RSM__EACH(m.v[piece] = m.v[piece] & n.v[piece])
    return m;
}

static inline RSM__IN_KERNEL rsm__lane_ints rsm__ints_load(const int32_t *from)
{
    rsm__lane_ints k;
    RSM__EACH(memcpy(&k.v[piece], from + piece * RSM__WIDTH, sizeof k.v[piece]))
    return k;
}

static inline RSM__IN_KERNEL void rsm__ints_store(int32_t *to, rsm__lane_ints k)
{
    RSM__EACH(memcpy(to + piece * RSM__WIDTH, &k.v[piece], sizeof k.v[piece]))
}

static inline RSM__IN_KERNEL rsm__lane_ints rsm__ints_all(int32_t x)
{
    rsm__lane_ints k;
#if RSM__SIMD_VECTORS
    const rsm__piece_ints all = { x, x, x, x };
    RSM__EACH(k.v[piece] = all)
#else
    RSM__EACH(k.v[piece] = x)
#endif
    return k;
}

static inline RSM__IN_KERNEL rsm__lane_ints rsm__ints_or(rsm__lane_ints k, rsm__lane_ints n)
{
    RSM__EACH(k.v[piece] = k.v[piece] | n.v[piece])
    return k;
}

/* Returns m ? k : 0. */
static inline RSM__IN_KERNEL rsm__lane_ints rsm__ints_keep(rsm__lane_mask m, rsm__lane_ints k)
{
    RSM__EACH(k.v[piece] = m.v[piece] & k.v[piece])
    return k;
}

#endif

/* ==== src/shared/simd_lanes3.h ==== */

/* unit simd_lanes3, needs simd_begin: vectors of three in lanes */

typedef struct rsm__lanes3 { rsm__lanes x, y, z; } rsm__lanes3;

static inline RSM__IN_KERNEL rsm__lanes3 rsm__lanes3_load(const float *x, const float *y, const float *z)
{
    rsm__lanes3 a;
    a.x = rsm__lanes_load(x);
    a.y = rsm__lanes_load(y);
    a.z = rsm__lanes_load(z);
    return a;
}

static inline RSM__IN_KERNEL rsm__lanes3 rsm__lanes3_all(float x, float y, float z)
{
    rsm__lanes3 a;
    a.x = rsm__lanes_all(x);
    a.y = rsm__lanes_all(y);
    a.z = rsm__lanes_all(z);
    return a;
}

static inline RSM__IN_KERNEL rsm__lanes3 rsm__lanes3_sub(rsm__lanes3 a, rsm__lanes3 b)
{
    a.x = rsm__lanes_sub(a.x, b.x);
    a.y = rsm__lanes_sub(a.y, b.y);
    a.z = rsm__lanes_sub(a.z, b.z);
    return a;
}

static inline RSM__IN_KERNEL rsm__lanes rsm__lanes3_dot(rsm__lanes3 a, rsm__lanes3 b)
{
    return rsm__lanes_add(rsm__lanes_add(rsm__lanes_mul(a.x, b.x), rsm__lanes_mul(a.y, b.y)),
                       rsm__lanes_mul(a.z, b.z));
}

/* ==== src/rsm/kernels_gather.h ==== */

/* ---- kernels of gather ---- */

/* As many pixel lights as there are lanes, or one light in every lane; and receivers in the same way. */
typedef struct rsm__lights { rsm__lanes3 position, normal, flux; rsm__lanes rounding, bound; } rsm__lights;
typedef struct rsm__receivers { rsm__lanes3 position, normal; rsm__lanes rounding; } rsm__receivers;

static inline RSM__IN_KERNEL rsm__lights rsm__lights_load(const rsm__block *k, size_t i)
{
    rsm__lights lights;
    lights.position = rsm__lanes3_load(k->px + i, k->py + i, k->pz + i);
    lights.normal = rsm__lanes3_load(k->nx + i, k->ny + i, k->nz + i);
    lights.flux = rsm__lanes3_load(k->r + i, k->g + i, k->b + i);
    lights.rounding = rsm__lanes_load(k->rounding + i);
    lights.bound = rsm__lanes_load(k->cap + i);
    return lights;
}

/* Returns the light of one lane of a block, in all lanes. */
static inline RSM__IN_KERNEL rsm__lights rsm__light_in_all(const rsm__block *k, size_t i)
{
    rsm__lights lights;
    lights.position = rsm__lanes3_all(k->px[i], k->py[i], k->pz[i]);
    lights.normal = rsm__lanes3_all(k->nx[i], k->ny[i], k->nz[i]);
    lights.flux = rsm__lanes3_all(k->r[i], k->g[i], k->b[i]);
    lights.rounding = rsm__lanes_all(k->rounding[i]);
    lights.bound = rsm__lanes_all(k->cap[i]);
    return lights;
}

/* The factor cos cos / d^2 of equation (1) for lights and receivers, computed as two cosines times d over
   d^4. The caller multiplies it by the flux, and by the 1 / pi that the equation lacks. */
typedef struct rsm__forms {
    rsm__lanes whole, bounded;     /* the factor without the light's bound and with it */
    rsm__lanes d2, inverse;        /* the squared distance, and one over it */
} rsm__forms;

/* Computes the factors. Cosines times d must exceed the rounding of both positions, so that a plane does not
   light itself (T40). */
static inline RSM__IN_KERNEL rsm__forms rsm__forms_make(const rsm__lights *lights,
                                                        const rsm__receivers *receivers)
{
    const rsm__lanes zero = rsm__lanes_all(0.0f),
        rounding = rsm__lanes_max(lights->rounding, receivers->rounding);
    const rsm__lanes3 d = rsm__lanes3_sub(lights->position, receivers->position);
    rsm__lanes at_receiver = rsm__lanes3_dot(receivers->normal, d);
    rsm__lanes at_light = rsm__lanes_negate(rsm__lanes3_dot(lights->normal, d));
    rsm__forms f;
    f.d2 = rsm__lanes3_dot(d, d);
    at_receiver = rsm__lanes_max(rsm__lanes_sub(at_receiver, rounding), zero);
    at_light = rsm__lanes_max(rsm__lanes_sub(at_light, rounding), zero);
    f.inverse = rsm__lanes_div(rsm__lanes_all(1.0f), rsm__lanes_max(f.d2, rsm__lanes_all(1e-18f)));
    f.whole = rsm__lanes_mul(rsm__lanes_mul(at_receiver, f.inverse), rsm__lanes_mul(at_light, f.inverse));
    f.bounded = rsm__lanes_min(f.whole, lights->bound);
    return f;
}

/* Sums of each lane, which are added up in one order at the end, so that all instruction sets give the same
   bits. */
typedef struct rsm__lane_sums { rsm__lanes red, green, blue, full, lost, nearby; } rsm__lane_sums;

static inline RSM__IN_KERNEL rsm__lane_sums rsm__sums_zero(void)
{
    rsm__lane_sums s;
    s.red = s.green = s.blue = s.full = s.lost = s.nearby = rsm__lanes_all(0.0f);
    return s;
}

/* Adds lights by their factors. */
static inline RSM__IN_KERNEL rsm__lane_sums rsm__sums_add(rsm__lane_sums s, const rsm__lights *lights,
                                                          const rsm__forms *f, int lossy)
{
    const rsm__lanes3 flux = lights->flux;
    s.red = rsm__lanes_add(s.red, rsm__lanes_mul(flux.x, f->bounded));
    s.green = rsm__lanes_add(s.green, rsm__lanes_mul(flux.y, f->bounded));
    s.blue = rsm__lanes_add(s.blue, rsm__lanes_mul(flux.z, f->bounded));
    if (lossy) {
        const rsm__lanes all = rsm__lanes_add(rsm__lanes_add(flux.x, flux.y), flux.z);
        s.full = rsm__lanes_add(s.full, rsm__lanes_mul(all, f->whole));
        s.lost = rsm__lanes_add(s.lost, rsm__lanes_mul(all, rsm__lanes_sub(f->whole, f->bounded)));
    }
    return s;
}

#if RSM__LANE_COUNT == 8                          /* in AVX-512 too, so that sums have the same bits */
/* Adds up the lanes, and adds them to a receiver's sum. */
static inline RSM__IN_KERNEL void rsm__sums_reduce(const rsm__lane_sums *s, int lossy, int nearest,
                                                 rsm__sum *sum)
{
    float red[8], green[8], blue[8];
    float full[8], lost[8], nearby[8];
    int l;
    rsm__lanes_store(red, s->red);
    rsm__lanes_store(green, s->green);
    rsm__lanes_store(blue, s->blue);
    rsm__lanes_store(full, s->full);
    rsm__lanes_store(lost, s->lost);
    rsm__lanes_store(nearby, s->nearby);
    for (l = 0; l < 8; l++) {
        sum->rgb[0] += red[l];
        sum->rgb[1] += green[l];
        sum->rgb[2] += blue[l];
        if (lossy) {
            sum->full += full[l];
            sum->lost += lost[l];
        }
        if (nearest) sum->nearby = nearby[l] > sum->nearby ? nearby[l] : sum->nearby;
    }
}

/* Adds the light of pixel lights, block by block, to one receiver's sum. lossy also sums what bounds take
   off; nearest finds the nearest light. */
static inline RSM__IN_KERNEL void rsm__sum_blocks(const rsm__block *k, size_t count, const float x[7],
                                                int lossy, int nearest, rsm__sum *sum)
{
    rsm__receivers receiver;
    rsm__lane_sums s = rsm__sums_zero();
    size_t i, end;
    receiver.position = rsm__lanes3_all(x[0], x[1], x[2]);
    receiver.normal = rsm__lanes3_all(x[3], x[4], x[5]);
    receiver.rounding = rsm__lanes_all(x[6]);
    for (; count > 0; count -= end, k++) {
        end = count < RSM__BLOCK ? count : (size_t)RSM__BLOCK;
        for (i = 0; i < end; i += 8) {
            const rsm__lights lights = rsm__lights_load(k, i);
            const rsm__forms f = rsm__forms_make(&lights, &receiver);
            s = rsm__sums_add(s, &lights, &f, lossy);
            if (nearest) {                       /* lights that are edge-on do not count */
                rsm__lane_mask seen = rsm__lanes_greater(rsm__lanes_mul(f.whole, f.d2),
                                                         rsm__lanes_all(1e-3f));
                s.nearby = rsm__lanes_max(rsm__lanes_keep(seen, f.inverse), s.nearby);
            }
        }
    }
    rsm__sums_reduce(&s, lossy, nearest, sum);
}

RSM__KERNEL static void rsm__sum_lights(const rsm__block *k, size_t count, const float x[7], rsm__sum *sum)
{
    rsm__sum_blocks(k, count, x, 0, 0, sum);
}

RSM__KERNEL static void rsm__sum_lights_lossy(const rsm__block *k, size_t count, const float x[7],
                                              rsm__sum *sum)
{
    rsm__sum_blocks(k, count, x, 1, 0, sum);
}

RSM__KERNEL static void rsm__sum_lights_near(const rsm__block *k, size_t count, const float x[7],
                                             rsm__sum *sum)
{
    rsm__sum_blocks(k, count, x, 0, 1, sum);
}

RSM__KERNEL static void rsm__sum_lights_near_lossy(const rsm__block *k, size_t count, const float x[7],
                                                   rsm__sum *sum)
{
    rsm__sum_blocks(k, count, x, 1, 1, sum);
}
#endif

/* Adds a few lights, one after the other, to the sums of as many receivers as there are lanes. */
static inline RSM__IN_KERNEL void rsm__sum_on_receivers(const rsm__block *k, size_t count, int lossy,
                                                        rsm__receiver_lanes *p)
{
    rsm__receivers receivers;
    rsm__lane_sums s = rsm__sums_zero();
    size_t i;
    receivers.position = rsm__lanes3_load(p->x[0], p->x[1], p->x[2]);
    receivers.normal = rsm__lanes3_load(p->x[3], p->x[4], p->x[5]);
    receivers.rounding = rsm__lanes_load(p->x[6]);
    for (i = 0; i < count; i++) {
        const rsm__lights light = rsm__light_in_all(k + i / RSM__BLOCK, i % RSM__BLOCK);
        const rsm__forms f = rsm__forms_make(&light, &receivers);
        s = rsm__sums_add(s, &light, &f, lossy);
    }
    rsm__lanes_store(p->sums[0], rsm__lanes_add(rsm__lanes_load(p->sums[0]), s.red));
    rsm__lanes_store(p->sums[1], rsm__lanes_add(rsm__lanes_load(p->sums[1]), s.green));
    rsm__lanes_store(p->sums[2], rsm__lanes_add(rsm__lanes_load(p->sums[2]), s.blue));
    rsm__lanes_store(p->sums[3], rsm__lanes_add(rsm__lanes_load(p->sums[3]), s.full));
    rsm__lanes_store(p->sums[4], rsm__lanes_add(rsm__lanes_load(p->sums[4]), s.lost));
}

RSM__KERNEL static void rsm__light_receivers(const rsm__block *k, size_t count, rsm__receiver_lanes *p)
{
    rsm__sum_on_receivers(k, count, 0, p);
}

RSM__KERNEL static void rsm__light_receivers_lossy(const rsm__block *k, size_t count, rsm__receiver_lanes *p)
{
    rsm__sum_on_receivers(k, count, 1, p);
}

/* ==== src/rsm/kernels_suit.h ==== */

/* ---- kernel of interpolation ---- */

#if RSM__LANE_COUNT == 8
/* Does what rsm__suit_kernel says, eight pixels at a time: count is a multiple of 8. */
RSM__KERNEL static void rsm__suit_tile(rsm__tile *t, size_t count, const float s[6], const float limits[3],
                                       int32_t bit)
{
    const rsm__lanes3 position = rsm__lanes3_all(s[0], s[1], s[2]),
        normal = rsm__lanes3_all(s[3], s[4], s[5]);
    size_t i;
    for (i = 0; i < count; i += 8) {
        const rsm__lanes3 d = rsm__lanes3_sub(position, rsm__lanes3_load(t->px + i, t->py + i, t->pz + i));
        const rsm__lanes3 n = rsm__lanes3_load(t->nx + i, t->ny + i, t->nz + i);
        const rsm__lanes d2 = rsm__lanes3_dot(d, d), plane = rsm__lanes3_dot(d, n),
            other = rsm__lanes3_dot(d, normal);
        const rsm__lanes most = rsm__lanes_mul(rsm__lanes_all(limits[1]), d2);
        rsm__lane_mask fits = rsm__lanes_at_least(rsm__lanes3_dot(normal, n), rsm__lanes_all(limits[0]));
        fits = rsm__mask_and(fits, rsm__lanes_at_least(most, rsm__lanes_mul(plane, plane)));
        fits = rsm__mask_and(fits, rsm__lanes_at_least(most, rsm__lanes_mul(other, other)));
        fits = rsm__mask_and(fits, rsm__lanes_at_least(rsm__lanes_all(limits[2]), d2));
        rsm__ints_store(t->good + i,
                        rsm__ints_or(rsm__ints_load(t->good + i), rsm__ints_keep(fits, rsm__ints_all(bit))));
    }
}
#endif

/* ==== src/rsm/kernels_end.h ==== */

#undef RSM__SET
#undef RSM__WIDTH
#undef RSM__LANE_COUNT
#endif /* RSM__SET */

#if defined(RSM_IMPLEMENTATION) && !defined(RSM_IMPLEMENTED)
#define RSM_IMPLEMENTED

/* ---- kernels: those of other instruction sets, and which to call ---- */

#if RSM__SIMD_SETS
#define RSM__SET avx2
#define RSM__WIDTH 8
#define RSM__LANE_COUNT 8
#include RSM__FILE
#define RSM__SET avx512
#define RSM__WIDTH 16
#define RSM__LANE_COUNT 16
#include RSM__FILE
#endif

static inline rsm__kernel rsm__choose_kernel(int lossy, int nearby)
{
#if RSM__SIMD_SETS
    if (rsm__simd_level() && nearby)
        return lossy ? rsm__sum_lights_near_lossy_avx2 : rsm__sum_lights_near_avx2;
    if (rsm__simd_level()) return lossy ? rsm__sum_lights_lossy_avx2 : rsm__sum_lights_avx2;
#endif
    if (nearby) return lossy ? rsm__sum_lights_near_lossy_plain : rsm__sum_lights_near_plain;
    return lossy ? rsm__sum_lights_lossy_plain : rsm__sum_lights_plain;
}

static inline rsm__receiver_lanes_kernel rsm__choose_receiver_lanes_kernel(int lossy, size_t *lanes)
{
    *lanes = 8;
#if RSM__SIMD_SETS
    if (rsm__simd_level() == 2) {
        *lanes = 16;
        return lossy ? rsm__light_receivers_lossy_avx512 : rsm__light_receivers_avx512;
    }
    if (rsm__simd_level()) return lossy ? rsm__light_receivers_lossy_avx2 : rsm__light_receivers_avx2;
#endif
    return lossy ? rsm__light_receivers_lossy_plain : rsm__light_receivers_plain;
}

static inline rsm__suit_kernel rsm__choose_suit(void)
{
#if RSM__SIMD_SETS
    if (rsm__simd_level()) return rsm__suit_tile_avx2;
#endif
    return rsm__suit_tile_plain;
}

/* ==== src/rsm/sources.h ==== */

/* ---- sources: what a gather takes its light from ---- */

/* The box about the positions of some lights, and most2, the largest squared distance at which one of them is
   near. A receiver that is farther from the box than that has none of them near. */
typedef struct rsm__reach { float low[3], high[3], most2; } rsm__reach;

typedef struct rsm__source {       /* the pixel lights of one map, or of a list */
    const rsm_map *map;            /* NULL: a list */
    rsm__block    *blocks;         /* the lights that all receivers share, set by set */
    rsm__gloss    *gloss;          /* their lobes, or NULL */
    uint32_t      *numbers;        /* of each lane, as visible_fn knows it; NULL without such a function */
    size_t         set_blocks;     /* blocks of one set */
    size_t         set_lights;     /* lights of one set */
    size_t         set_lanes;      /* lanes of these lights, a multiple of RSM__LANES */
    rsm__reach    *reaches;        /* of each block, then of each run of blocks; NULL: all lights are points
                                      */
    size_t         set_runs;       /* runs of one set */
} rsm__source;

typedef struct rsm__tally {        /* what one task has counted */
    uint64_t evaluated, pairs, bad;
    double   full, lost;           /* sums of those of rsm__sum */
    double   outside, looked;      /* the sum of shares of flux outside r_max, and of how many receivers */
} rsm__tally;

typedef struct rsm__gather {       /* one call of rsm_gather, rsm_gather_list or rsm_interpolate */
    const rsm_map *const *maps;
    rsm_gather_desc   desc;                      /* with its defaults filled in */
    const rsm_points *points;
    float            *out;
    rsm__source      *sources;
    size_t            source_count;
    size_t            count;                     /* receivers */
    float            *pattern;                   /* x, y and weight of each sample, set by set */
    uint32_t          sets;                      /* interleave^2 */
    size_t            numbered;                  /* lights of the sources before that visible_fn knows */
    uint32_t          set_samples;               /* samples of the pattern in each set */
    uint32_t          shared, centred;           /* samples that all receivers share, and samples about each
                                                    receiver; MIXED has both */
    rsm__kernel       kernel;
    rsm__receiver_lanes_kernel lanes_kernel;
    size_t            receiver_lane_count;
    rsm__tally       *tallies;                   /* one for each batch or row */
    float             scale;                     /* the factor of results, 1 / pi */
    float            *reach2;                    /* receives the squared distance of each point's nearest
                                                    light; may be NULL */
} rsm__gather;

/* Puts a light into lane i. weight says how many such texels the light stands for, sets how many sets share
   the lights. A light counts `sets` times in its set, but its bound is that of the light among all sets, so
   that interleaving changes nothing on average. */
static inline void rsm__lane_set(const rsm_gather_desc *d, rsm__block *k, size_t i, const rsm_texel *t,
                                 float weight, float sets)
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

/* Notes in lane i the squared distance within which its texel is near, and the face that the texel lies in.
   */
static inline void rsm__lane_near(const rsm_gather_desc *d, const rsm_map *map, rsm__block *k, size_t i,
                                  size_t at)
{
    float area = map->texels[at].area;
    k->density[i] = d->near_field * d->near_field * (area > 0.0f ? area : 0.0f);
    k->lx[i] = map->faces == 1 ? 0.0f : (float)(at / ((size_t)map->side * map->side));
}

static inline void rsm__lane_clear(rsm__block *k, size_t i)
{
    k->px[i] = k->py[i] = k->pz[i] = k->nx[i] = k->ny[i] = k->nz[i] = k->r[i] = k->g[i] = k->b[i] = 0.0f;
    k->rounding[i] = 0.0f;
    k->cap[i] = RSM__NO_CAP;
    k->lx[i] = k->ly[i] = k->lz[i] = k->density[i] = 0.0f;
}

/* Makes the Phong lobe of texel number `at` of a map. The lobe of a texel without a material is 0. */
static inline void rsm__gloss_set(const rsm_gather_desc *d, const rsm_map *map, rsm__gloss *g, size_t at,
                                  float weight)
{
    const rsm_texel *t = map->texels + at;
    size_t face = (size_t)map->side * map->side;
    rsm__v3 n = rsm__v3_load(t->normal), l = rsm__to_light(map, rsm__v3_load(t->position));
    float incident;
    int c;
    memset(g, 0, sizeof *g);
    if (t->material == 0 || t->material > d->material_count || !(t->depth < RSM_FAR)) return;
    rsm__v3_store(g->mirror, rsm__v3_sub(rsm__v3_scale(n, 2.0f * rsm__v3_dot(n, l)), l));
    g->exponent = d->materials[t->material - 1].exponent;
    incident = rsm__texel_incident(map, (uint32_t)(at / face), (uint32_t)(at % map->side),
                             (uint32_t)(at % face / map->side));
    for (c = 0; c < 3; c++)
        g->scale[c] = incident * map->desc.light.value[c] * weight *
                      d->materials[t->material - 1].specular[c] * 0.5f * (g->exponent + 2.0f);
}

/* Picks sample i of n in proportion to flux: writes the number of its texel and how many such texels it
   stands for. Returns 0 where the map has no flux. */
static inline int rsm__pick_texel(const rsm_map *map, uint32_t i, uint32_t n, uint32_t seed, size_t *at,
                                  float *weight)
{
    double total = map->rows[map->side * (size_t)map->faces], x, flux;
    uint32_t low = 0, high = map->side * map->faces, row;
    const double *sums;
    float u, v;
    if (!(total > 0.0)) return 0;
    /* Samples are a lattice: rows at even steps of flux, places in a row by the golden ratio, both shifted by
       the seed. */
    u = rsm__fraction(rsm__to_unit(i * 2654435769u) + rsm__random(seed, 5, 0));
    v = ((float)i + rsm__random(seed, 6, 0)) / (float)n;
    x = (double)(v < 0.99999994f ? v : 0.99999994f) * total;
    while (high - low > 1u) {
        uint32_t middle = low + (high - low) / 2u;
        if (map->rows[middle] <= x) low = middle;
        else high = middle;
    }
    row = low;
    sums = map->sums + (size_t)row * map->side;
    x = (double)(u < 0.99999994f ? u : 0.99999994f) * sums[map->side - 1];
    low = 0;
    high = map->side - 1; /* the first texel whose sum exceeds x is searched */
    while (low < high) {
        uint32_t middle = low + (high - low) / 2u;
        if (sums[middle] > x) high = middle;
        else low = middle + 1u;
    }
    flux = sums[low] - (low ? sums[low - 1] : 0.0);
    if (!(flux > 0.0)) return 0;
    *at = (size_t)row * map->side + low;
    *weight = (float)(total / ((double)n * flux));
    return 1;
}

/* ==== src/rsm/near_field.h ==== */

/* ---- near field: texels as the parallelograms that they are ---- */

/* Writes half the sides of the surface under a texel at p: the cross section of the texel's beam, carried
   along the beam onto the plane of n. The cosine counts as 0.05 at least, as in rsm_texel.area, so that both
   have the same area. */
static inline void rsm__texel_sides(const rsm_map *map, uint32_t face, rsm__v3 p, rsm__v3 n, rsm__v3 side[2])
{
    rsm__v3 a, d, along;
    float scale = map->extent / (float)map->side, facing, least;
    float bounded, length2;
    int k;
    rsm__face_frame(map, face, &side[0], &side[1], &a);
    d = a;
    if (!rsm__is_sun(map)) { /* d goes from the light to the plane at distance 1 */
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

/* Returns what the edge from a to b adds to Lambert's sum: angle(a, b) n . (b x a) / |b x a|. */
static inline float rsm__lambert_edge(rsm__v3 n, rsm__v3 a, rsm__v3 b)
{
    rsm__v3 c = rsm__v3_cross(rsm__v3_sub(b, a), a);
    float length = rsm__v3_length(c);
    return length > 0.0f ? rsm__atan2(length, rsm__v3_dot(a, b)) * (rsm__v3_dot(n, c) / length) : 0.0f;
}

/* Returns the integral of cos cos / d^2 over the parallelogram c +- u +- v, seen from the origin and clipped
   at the horizon of n. This is pi times the form factor, which is half of Lambert's sum over the edges (Baum,
   Rushmeier and Winget 1989). A parallelogram is convex, so that its outline goes below the horizon at one
   point (leave) and comes back at one other (come) at most; an edge from one to the other closes the outline
   again. */
static inline float rsm__parallelogram_form(rsm__v3 n, rsm__v3 c, rsm__v3 u, rsm__v3 v)
{
    rsm__v3 corner[4], leave = c, come = c;
    float height[4], sum = 0.0f;
    int k;
    for (k = 0; k < 4; k++) {
        corner[k] =
            rsm__v3_madd(rsm__v3_madd(c, u, k == 1 || k == 2 ? 1.0f : -1.0f), v, k > 1 ? 1.0f : -1.0f);
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
        sum += rsm__lambert_edge(n, a, b);
    }
    return 0.5f * fabsf(sum + rsm__lambert_edge(n, leave, come));
}

/* Returns the mean of cos cos / d^2 over the texel in lane i. As with points, a plane does not light itself.
   A receiver may lie nearer to the texel's plane than half its side and face it: so lies the back of a bent
   sheet that is lit from its other side, through which the parallelogram reaches, and depths cannot tell the
   two apart. For such a receiver the form goes over to that of a point by degrees, and reaches it at distance
   0 with 120 degrees or more between the normals. */
static inline float rsm__near_texel_form(const rsm_map *map, const rsm__block *k, size_t i, const float x[7])
{
    rsm__v3 p = rsm__v3_make(k->px[i], k->py[i], k->pz[i]), n = rsm__v3_make(k->nx[i], k->ny[i], k->nz[i]),
            side[2];
    rsm__v3 d = rsm__v3_sub(p, rsm__v3_load(x));
    float area, form, point;
    float height = -rsm__v3_dot(n, d), d2 = rsm__v3_dot(d, d);
    float facing = -2.0f * rsm__v3_dot(n, rsm__v3_load(x + 3)), above = rsm__v3_dot(rsm__v3_load(x + 3), d);
    if (!(height > (k->rounding[i] > x[6] ? k->rounding[i] : x[6]))) return 0.0f;
    rsm__texel_sides(map, (uint32_t)k->lx[i], p, n, side);
    area = 4.0f * rsm__v3_length(rsm__v3_cross(side[0], side[1]));
    form = area > 0.0f ? rsm__parallelogram_form(rsm__v3_load(x + 3), d, side[0], side[1]) / area : 0.0f;
    point = above > 0.0f ? (above / d2) * (height / d2) : 0.0f;
    if (form > point && facing > 0.0f && 4.0f * height * height < area)
        form += (facing < 1.0f ? facing : 1.0f) * (1.0f - 2.0f * height / sqrtf(area)) * (point - form);
    return form > 0.0f ? form : 0.0f; /* 0 for NaN, which positions make whose squares floats cannot hold */
}

/* Returns whether the light in lane i is near the receiver. */
static inline int rsm__is_near(const rsm__block *k, size_t i, const float x[7])
{
    float dx = k->px[i] - x[0], dy = k->py[i] - x[1], dz = k->pz[i] - x[2];
    return dx * dx + dy * dy + dz * dz < k->density[i];
}

/* Runs the kernel on a block of which some lights may be near. These are taken out of the block, which is not
   restored, and added one by one as parallelograms. */
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
        float form = rsm__near_texel_form(map, k, found[j], x),
              f = form < k->cap[found[j]] ? form : k->cap[found[j]];
        int c;
        for (c = 0; c < 3; c++) {
            sum->rgb[c] += flux[j][c] * f;
            sum->full += flux[j][c] * form;
            sum->lost += flux[j][c] * (form - f);
        }
    }
}

/* Returns whether a light of the box may be near the receiver. */
static inline int rsm__is_within_reach(const rsm__reach *r, const float x[7])
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

/* Makes the boxes of a source's blocks and those of its runs, both set by set, once its lights are in place.
   */
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

/* Gathers from one run of a set's lights, of which some may be near. The run begins at lane `first`. */
static inline void rsm__gather_near(const rsm__gather *g, const rsm__source *s, uint32_t set, size_t first,
                                    size_t lanes, const float x[7], rsm__sum *sum)
{
    size_t i, at = set * s->set_blocks + first / RSM__BLOCK;
    for (i = 0; i < lanes; i += RSM__BLOCK, at++) {
        size_t count = lanes - i < RSM__BLOCK ? lanes - i : (size_t)RSM__BLOCK;
        if (rsm__is_within_reach(&s->reaches[at], x)) {
            rsm__block some = s->blocks[at];
            rsm__kernel_near(g, s->map, &some, count, x, sum);
        } else g->kernel(s->blocks + at, count, x, sum);
    }
}

/* ==== src/rsm/centred.h ==== */

/* ---- centred: samples about the projection of a receiver (equation 3), and MIXED ---- */

/* MIXED samples a texel in two ways, weighted by the balance heuristic (Veach and Guibas 1995). By flux there
   are n1 P expected samples of the texel, where P is its share of the flux; about the receiver there are B /
   q, where q is the squared distance from the receiver's projection in the map. This function returns B. If
   lights are near, q is small and the second way takes over, with samples so dense that no single one is
   bright. The sum is unbiased by any q that both ways compute alike; this q makes the log-radial density with
   its inner disc rounded off. */
static inline float rsm__mixed_scale(const rsm__gather *g, const rsm_map *map)
{
    /* The density is C / r^2 over a disc of unit radius with r_min = 1/192, so C is 1 / (2 pi (log 192 +
       1/2)). A texel of a cube has 1 / (6 side^2) of the disc's area pi. */
    return (float)g->centred * 0.02764f * (map->faces == 1 ? 1.0f : 0.5236f) /
           ((float)map->side * (float)map->side);
}

/* The r_min of MIXED, which is so small that texels about a corner are taken nearly one by one, and its
   square. */
#define RSM__MIXED_MIN (1.0f / 192.0f)
#define RSM__MIXED_INNER 2.7127e-5f

/* Returns the place of texel (i, j) between which MIXED measures distances: a point of the unit square, or
   for a cube a point of the sphere of diameter 1. */
static inline rsm__v3 rsm__mixed_place(const rsm_map *map, uint32_t face, uint32_t i, uint32_t j)
{
    float u = rsm__texel_centre(map, i), v = rsm__texel_centre(map, j);
    rsm__v3 r, up, a;
    if (map->faces == 1) return rsm__v3_make(u * 0.5f + 0.5f, v * 0.5f + 0.5f, 0.0f);
    rsm__face_frame(map, face, &r, &up, &a);
    return rsm__v3_scale(rsm__v3_normalize(rsm__v3_madd(rsm__v3_madd(a, r, u), up, v)), 0.5f);
}

/* Returns the centre of the patterns about a receiver at p: a point of the unit square, which with `inside`
   is moved into the map, or for a cube a direction, of which two axes across are written to frame. */
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
    if (inside) {                                /* any centre in the map would do; the nearest is best */
        centre.x = centre.x > 0.02f ? centre.x < 0.98f ? centre.x : 0.98f : 0.02f;
        centre.y = centre.y > 0.02f ? centre.y < 0.98f ? centre.y : 0.98f : 0.02f;
    }
    return centre;
}

/* Returns the number of the texel under a sample of a pattern about the receiver, or (size_t)-1 if the sample
   lies outside of the map, and writes how many texels the sample stands for. centre and frame are those of
   rsm__centre_of. place receives the texel's place for MIXED, and may be NULL. */
static inline size_t rsm__place_sample(const rsm_map *map, float r_max, rsm__v3 centre,
                                       const rsm__v3 frame[2], const float sample[3], float *weight,
                                       rsm__v3 *place)
{
    float x = sample[0], y = sample[1], side = (float)map->side;
    uint32_t i, j, face = 0;
    if (map->faces == 1) {
        float r = r_max;
        if (!(r > 0.0f)) { /* the pattern ends at the border: the ray's length scales both radius and area */
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
        if (!(r_max > 0.0f)) { /* rounding must not lose samples that lie on the border */
            x = x < 0.0f ? 0.0f : x >= side ? side - 0.5f : x;
            y = y < 0.0f ? 0.0f : y >= side ? side - 0.5f : y;
        }
        if (!(x >= 0.0f && x < side && y >= 0.0f && y < side)) return (size_t)-1;
        i = (uint32_t)x;
        j = (uint32_t)y;
    } else { /* the disc is mapped to the sphere with equal areas: r = sin(angle / 2) */
        float r = r_max > 0.0f && r_max < 1.0f ? r_max : 1.0f, t, height;
        float q, u, v;
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
        i = i < map->side ? i : map->side - 1u;
        j = j < map->side ? j : map->side - 1u;
        u = rsm__texel_centre(map, i);
        v = rsm__texel_centre(map, j);
        q = 1.0f + u * u + v * v; /* the solid angle of the texel is (2 / side)^2 / q^1.5 */
        *weight = sample[2] * 4.0f * r * r * 0.25f * side * side * q * sqrtf(q);
    }
    if (place) *place = rsm__mixed_place(map, face, i, j);
    return ((size_t)face * map->side + j) * map->side + i;
}

/* Gathers from the pixel lights that a pattern finds about one receiver. */
static inline void rsm__gather_centred(const rsm__gather *g, const rsm_map *map, const float x[7],
                                       uint32_t set, float noise, rsm__sum *sum)
{
    rsm__v3 frame[2], centre, middle, places[RSM__BLOCK];
    rsm__block block;
    size_t found[RSM__BLOCK];
    float weights[RSM__BLOCK], s = 0.0f, c = 1.0f, scale = rsm__mixed_scale(g, map);
    float total = (float)map->rows[(size_t)map->side * map->faces];
    uint32_t first, i, k, n;
    int nearby = g->desc.near_field > 0.0f;
    frame[0] = frame[1] = rsm__v3_make(0, 0, 0);
    if (g->desc.noise) rsm__sincos(noise * (2.0f * RSM__PI), &s, &c);
    centre = rsm__centre_of(map, rsm__v3_make(x[0], x[1], x[2]), !(g->desc.r_max > 0.0f), frame);
    middle = rsm__v3_scale(centre, map->faces == 1 ? 1.0f : 0.5f);
    for (first = 0; first < g->set_samples; first += RSM__BLOCK) {
        const float *pattern = g->pattern + 3 * ((size_t)set * g->set_samples + first);
        n = g->set_samples - first < RSM__BLOCK ? g->set_samples - first : (uint32_t)RSM__BLOCK;
        for (i = 0; i < n; i++) { /* texels lie all over the map, so all are prefetched before any is read */
            const float *p = pattern + 3 * i, sample[3] = { p[0] * c - p[1] * s, p[0] * s + p[1] * c, p[2] };
            found[i] = rsm__place_sample(map, g->desc.r_max, centre, frame, sample, &weights[i],
                                         g->shared ? &places[i] : NULL);
            if (found[i] != (size_t)-1) RSM__PREFETCH(&map->texels[found[i]].flux);
        }
        for (i = 0; g->shared && i < n; i++) {
            rsm__v3 d;
            float q;
            if (found[i] == (size_t)-1) continue;
            d = rsm__v3_sub(places[i], middle);
            q = (rsm__v3_dot(d, d) + RSM__MIXED_INNER) * (float)g->shared *
                rsm__mean3(map->texels[found[i]].flux);
            if (total > 0.0f) weights[i] *= scale / (q / total + scale);
        }
        for (i = 0; i < n; i++)
            if (found[i] != (size_t)-1 &&
                (g->desc.materials || rsm__mean3(map->texels[found[i]].flux) > 0.0f))
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
            rsm__add_gloss(
                &gloss, &block, i, x,
                nearby && rsm__is_near(&block, i, x) ? rsm__near_texel_form(map, &block, i, x) : -1.0f, sum);
        }
    }
}

/* Returns the share of a map's flux that lies beyond r_max of a receiver at p. */
static inline double rsm__outside_share(const rsm_map *map, float r_max, rsm__v3 p)
{
    double outside = 0.0, total = map->rows[(size_t)map->side * map->faces];
    size_t at, face = (size_t)map->side * map->side, count = rsm__texel_count(map);
    rsm__v3 q = rsm__to_face(map, 0, p), centre;
    if (!(total > 0.0)) return 0.0;
    centre = rsm__v3_normalize(rsm__v3_sub(p, rsm__v3_load(map->desc.light.position)));
    if (map->faces == 1 && !rsm__is_sun(map) && !(q.z > 0.0f)) q = rsm__v3_make(0, 0, 0);
    for (at = 0; at < count; at++) {
        float u = rsm__texel_centre(map, (uint32_t)(at % map->side));
        float v = rsm__texel_centre(map, (uint32_t)(at % face / map->side));
        float f = rsm__mean3(map->texels[at].flux), d;
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

/* ==== src/rsm/shared_lights.h ==== */

/* ---- shared lights: those that all receivers take ---- */

/* Returns texel number i of a map in an order of tiles: 32 x 32 texels, which are a run, in tiles of 8 x 8,
   which are a block. So the lights of runs and blocks lie close together, and few of these are near a
   receiver. Returns (size_t)-1 for a place of a tile that lies outside the map. */
static inline size_t rsm__tiled_texel(const rsm_map *map, size_t i)
{
    size_t tiles = (map->side + 31u) / 32u, tile = i / 1024u, face = tile / (tiles * tiles);
    size_t x = tile % tiles * 32u + (i >> 6 & 3u) * 8u + (i & 7u);
    size_t y = tile / tiles % tiles * 32u + (i >> 8 & 3u) * 8u + (i >> 3 & 7u);
    return x < map->side && y < map->side ? (face * map->side + y) * map->side + x : (size_t)-1;
}

/* Returns whether a texel gives light: it has diffuse flux, or a lobe, which black texels may have too. For
   visible_fn black texels have no number. */
static inline int rsm__gives_light(const rsm__gather *g, const rsm_texel *t)
{
    return rsm__mean3(t->flux) > 0.0f ||
           (!g->desc.visible_fn && t->material != 0 && t->material <= g->desc.material_count &&
            t->depth < RSM_FAR);
}

/* Makes room for the number of each lane. Returns 0 if there is no memory. */
static inline int rsm__make_numbers(rsm__source *s, size_t lanes, const rsm__allocator *a)
{
    s->numbers = (uint32_t *)rsm__alloc_array(a, lanes, sizeof *s->numbers);
    if (s->numbers) memset(s->numbers, 0, lanes * sizeof *s->numbers);
    return s->numbers != NULL;
}

/* Returns how many texels of a map give light. */
static inline size_t rsm__count_texels(const rsm__gather *g, const rsm_map *map)
{
    size_t at, texels = rsm__texel_count(map), count = 0;
    if (!g->desc.materials || g->desc.visible_fn) return (size_t)map->stats.lit_texels;
    for (at = 0; at < texels; at++) count += (size_t)rsm__gives_light(g, map->texels + at);
    return count;
}

/* Packs the pixel lights of a map that all receivers share into blocks, set by set, each set padded to whole
   blocks. */
static inline rsm_result rsm__pack_map(rsm__gather *g, rsm__source *s, const rsm__allocator *a)
{
    const rsm_map *map = s->map;
    size_t texels = rsm__texel_count(map);
    size_t count = g->desc.sample_count ? g->shared : rsm__count_texels(g, map);
    size_t per_set = (count + g->sets - 1) / g->sets, i, at = 0;
    size_t placed = 0, lanes;
    int nearby = g->desc.near_field > 0.0f && g->desc.sample_count == 0;
    int tiled = nearby && g->sets == 1 && !g->desc.visible_fn; /* numbers count texels row by row */
    if (tiled) texels = (size_t)map->faces * ((map->side + 31u) / 32u) * ((map->side + 31u) / 32u) * 1024u;
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
    if (g->desc.visible_fn && !rsm__make_numbers(s, lanes, a)) return RSM_ERR_ALLOC;
    for (i = 0; i < (g->desc.sample_count ? count : texels); i++) {
        size_t set, lane;
        float weight = 1.0f;
        if (g->desc.sample_count) {
            if (!rsm__pick_texel(map, (uint32_t)i, (uint32_t)count, g->desc.seed, &at, &weight)) continue;
        } else {
            at = tiled ? rsm__tiled_texel(map, i) : i;
            if (at == (size_t)-1 || !rsm__gives_light(g, map->texels + at)) continue;
        }
        set = rsm__hash_combine(g->desc.seed, (uint32_t)(placed / g->sets));
        set = (placed + set) % g->sets; /* each run of `sets` neighbours is dealt out to all sets, in an order
                                           of its own */
        lane = set * s->set_blocks * RSM__BLOCK + placed / g->sets;
        rsm__lane_set(&g->desc, s->blocks + lane / RSM__BLOCK, lane % RSM__BLOCK, map->texels + at, weight,
                      (float)g->sets);
        if (g->centred) {
            rsm__block *k = s->blocks + lane / RSM__BLOCK;
            size_t row = at / map->side;
            rsm__v3 place = rsm__mixed_place(map, (uint32_t)(row / map->side), (uint32_t)(at % map->side),
                                             (uint32_t)(row % map->side));
            k->lx[lane % RSM__BLOCK] = place.x;
            k->ly[lane % RSM__BLOCK] = place.y;
            k->lz[lane % RSM__BLOCK] = place.z;
            k->density[lane % RSM__BLOCK] = 1.0f / weight;
        }
        if (s->gloss) rsm__gloss_set(&g->desc, map, s->gloss + lane, at, weight * (float)g->sets);
        if (nearby) rsm__lane_near(&g->desc, map, s->blocks + lane / RSM__BLOCK, lane % RSM__BLOCK, at);
        if (s->numbers) s->numbers[lane] = (uint32_t)(g->numbered + placed);
        placed++;
    }
    g->numbered += placed;
    return nearby ? rsm__find_reaches(g, s, a) : RSM_OK;
}

/* Packs a list of pixel lights into blocks, set by set. A light that cannot be used leaves its lane empty. */
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
    if (g->desc.visible_fn && !rsm__make_numbers(s, lanes, a)) return RSM_ERR_ALLOC;
    for (i = 0; i < count; i++) {
        size_t lane = i % g->sets * s->set_blocks * RSM__BLOCK + i / g->sets;
        if (s->numbers) s->numbers[lane] = (uint32_t)i;
        if (rsm__is_usable(rsm__v3_load(lights[i].position)) &&
            rsm__is_usable(rsm__v3_load(lights[i].normal)) && lights[i].flux[0] >= 0.0f &&
            lights[i].flux[1] >= 0.0f && lights[i].flux[2] >= 0.0f &&
            rsm__mean3(lights[i].flux) <= 1e18f)
            rsm__lane_set(&g->desc, s->blocks + lane / RSM__BLOCK, lane % RSM__BLOCK, lights + i, 1.0f,
                          (float)g->sets);
    }
    return RSM_OK;
}

/* Adds the lobes of the lights of block `at`, each times its factor; NULL = 1. */
static inline void rsm__gather_gloss(const rsm__source *s, size_t at, size_t lanes, const float *factors,
                                     const float x[7], rsm__sum *sum)
{
    const rsm__block *block = s->blocks + at;
    size_t k;
    int c;
    for (k = 0; k < lanes; k++) {
        rsm__gloss gloss = s->gloss[at * RSM__BLOCK + k];
        float mean;
        if (!(gloss.scale[0] > 0.0f || gloss.scale[1] > 0.0f || gloss.scale[2] > 0.0f)) continue;
        for (c = 0; c < 3 && factors; c++) gloss.scale[c] *= factors[k];
        mean = s->reaches && rsm__is_near(block, k, x) ? rsm__near_texel_form(s->map, block, k, x) : -1.0f;
        rsm__add_gloss(&gloss, block, k, x, mean, sum);
    }
}

/* Asks visible_fn about those lights of block `at` that could light the receiver, and writes for each lane
   how much the receiver sees of it: 0 for the others. A near texel may reach over the receiver's horizon,
   though its centre lies below. */
static inline void rsm__see_block(const rsm__gather *g, const rsm__source *s, size_t at, size_t lanes,
                                  const float x[7], float seen[RSM__BLOCK])
{
    const rsm__block *b = s->blocks + at;
    float visible[RSM__BLOCK];
    uint32_t numbers[RSM__BLOCK];
    size_t lane[RSM__BLOCK], asked = 0, k;
    for (k = 0; k < lanes; k++) {
        float dx = b->px[k] - x[0], dy = b->py[k] - x[1], dz = b->pz[k] - x[2];
        seen[k] = 0.0f;
        if (!(b->nx[k] * dx + b->ny[k] * dy + b->nz[k] * dz < 0.0f)) continue;
        if (!(x[3] * dx + x[4] * dy + x[5] * dz > 0.0f) && !(s->reaches && rsm__is_near(b, k, x))) continue;
        numbers[asked] = s->numbers[at * RSM__BLOCK + k];
        visible[asked] = 0.0f;
        lane[asked++] = k;
    }
    if (asked) g->desc.visible_fn(g->desc.visible_user, x, x + 3, numbers, asked, visible);
    for (k = 0; k < asked; k++)
        seen[lane[k]] = visible[k] > 0.0f ? visible[k] < 1.0f ? visible[k] : 1.0f : 0.0f;
}

/* Gathers from the lights of a source that all receivers share, as visible_fn lets each receiver see them. */
static inline void rsm__gather_seen(const rsm__gather *g, const rsm__source *s, const float x[7],
                                    uint32_t set, rsm__sum *sum)
{
    size_t i, k;
    for (i = 0; i < s->set_blocks; i++) {
        size_t at = set * s->set_blocks + i, left = s->set_lanes - i * RSM__BLOCK;
        size_t lanes = left < RSM__BLOCK ? left : (size_t)RSM__BLOCK;
        rsm__block block = s->blocks[at];
        float seen[RSM__BLOCK];
        rsm__see_block(g, s, at, lanes, x, seen);
        for (k = 0; k < lanes; k++) {
            block.r[k] *= seen[k];
            block.g[k] *= seen[k];
            block.b[k] *= seen[k];
        }
        if (s->reaches && rsm__is_within_reach(s->reaches + at, x))
            rsm__kernel_near(g, s->map, &block, lanes, x, sum);
        else g->kernel(&block, lanes, x, sum);
        if (s->gloss) rsm__gather_gloss(s, at, lanes, seen, x, sum);
    }
}

/* Gathers from the lights of a source that all receivers share: by runs, or block by block if MIXED weighs
   each light for this receiver. */
static inline void rsm__gather_shared(const rsm__gather *g, const rsm__source *s, const float x[7],
                                      uint32_t set, rsm__sum *sum)
{
    const rsm__block *blocks = s->blocks + set * s->set_blocks;
    const rsm__reach *runs = s->reaches ? s->reaches + s->set_blocks * g->sets + set * s->set_runs : NULL;
    rsm__block mixed;
    rsm__v3 frame[2], centre;
    float scale = 0.0f;
    size_t i, k;
    if (s->numbers) {
        rsm__gather_seen(g, s, x, set, sum);
        return;
    }
    centre = rsm__v3_make(0, 0, 0);
    if (g->centred && s->map) {
        centre = rsm__v3_scale(rsm__centre_of(s->map, rsm__v3_make(x[0], x[1], x[2]), 1, frame),
                               s->map->faces == 1 ? 1.0f : 0.5f);
        scale = rsm__mixed_scale(g, s->map);
    }
    for (i = 0; i < s->set_lanes && !(scale > 0.0f); i += RSM__RUN) {
        /* Sums are short, since long ones of floats lose bits where lights are many. */
        size_t lanes = s->set_lanes - i < RSM__RUN ? s->set_lanes - i : (size_t)RSM__RUN;
        if (runs && rsm__is_within_reach(runs + i / RSM__RUN, x))
            rsm__gather_near(g, s, set, i, lanes, x, sum);
        else g->kernel(blocks + i / RSM__BLOCK, lanes, x, sum);
    }
    for (i = 0; i < s->set_blocks && (scale > 0.0f || s->gloss); i++) {
        size_t lanes =
            s->set_lanes - i * RSM__BLOCK < RSM__BLOCK ? s->set_lanes - i * RSM__BLOCK : (size_t)RSM__BLOCK;
        if (scale > 0.0f) {
            mixed = blocks[i];
            for (k = 0; k < lanes; k++) {
                float dx = mixed.lx[k] - centre.x, dy = mixed.ly[k] - centre.y, dz = mixed.lz[k] - centre.z;
                float q = (dx * dx + dy * dy + dz * dz + RSM__MIXED_INNER) * mixed.density[k],
                      w = q / (q + scale);
                mixed.r[k] *= w;
                mixed.g[k] *= w;
                mixed.b[k] *= w;
                mixed.density[k] = w;
            }
            g->kernel(&mixed, lanes, x, sum);
        }
        if (s->gloss)
            rsm__gather_gloss(s, set * s->set_blocks + i, lanes, scale > 0.0f ? mixed.density : NULL, x, sum);
    }
}

/* ==== src/rsm/gather.h ==== */

/* ---- gather: bounced light of receivers (equations 1 and 2) ---- */

/* Writes or adds the result of receiver `at`, times the share that is open there. */
static inline void rsm__write_sum(const rsm__gather *g, size_t at, const float rgb[3])
{
    const rsm_points *p = g->points;
    float open = 1.0f, *out = g->out + 3 * at;
    int c;
    if (p->open) open = *rsm__element_at(p->open, rsm__stride_or(p->open_stride, 4), at);
    open = open > 0.0f ? open < 1.0f ? open : 1.0f : 0.0f;
    for (c = 0; c < 3; c++) out[c] = (g->desc.add ? out[c] : 0.0f) + rgb[c] * g->scale * open;
}

/* Gathers for one receiver, the number-th of those asked for. With wants_share it also finds the share of
   flux that lies beyond r_max. */
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
    if (!rsm__load_receiver(p, at, &position, &normal, &tally->bad)) {
        for (c = 0; c < 3 && !g->desc.add; c++) out[c] = 0.0f;
        return;
    }
    if (g->desc.noise)
        noise = g->desc.noise[py % g->desc.noise_side * g->desc.noise_side + px % g->desc.noise_side];
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

/* Gathers for a batch of receivers. */
static inline void rsm__gather_batch(void *context, size_t batch)
{
    const rsm__gather *g = (const rsm__gather *)context;
    rsm__tally *tally = g->tallies + batch;
    size_t i, first = batch * RSM__BATCH, end = first + RSM__BATCH < g->count ? first + RSM__BATCH : g->count;
    size_t every = g->count / 64 + 1;
    memset(tally, 0, sizeof *tally);
    for (i = first; i < end; i++) rsm__gather_one(g, i, tally, i % every == 0);
}

/* Returns whether the pixels of a row that take the same set are gathered for together, as many as a vector
   has lanes. So it is for interleaved pictures with few lights a set. */
static inline int rsm__gathers_by_rows(const rsm__gather *g)
{
    size_t i;
    if (g->desc.visible_fn) return 0;
    if (g->sets == 1 || g->pattern || g->desc.materials || g->points->width == 0 || g->points->indices)
        return 0;
    for (i = 0; i < g->source_count; i++) /* sums of more lights would lose bits; more lights fill the lanes
                                             anyway */
        if (g->sources[i].reaches || g->sources[i].set_lanes > RSM__FEW) return 0;
    return 1;
}

/* Puts receiver `at` into the next lane; a receiver that is none gets its result at once. */
static inline void rsm__receiver_lanes_add(const rsm__gather *g, rsm__receiver_lanes *p, size_t at,
                                           rsm__tally *tally)
{
    rsm__v3 position, normal;
    float x[6];
    int c;
    if (!rsm__load_receiver(g->points, at, &position, &normal, &tally->bad)) {
        for (c = 0; c < 3 && !g->desc.add; c++) g->out[3 * at + (size_t)c] = 0.0f;
        return;
    }
    rsm__v3_store(x, position);
    rsm__v3_store(x + 3, normal);
    for (c = 0; c < 6; c++) p->x[c][p->count] = x[c];
    p->x[6][p->count] = rsm__rounding(x[0], x[1], x[2]);
    p->at[p->count++] = at;
}

/* Gathers from one set for all lanes that are filled, writes their results and empties the lanes. */
static inline void rsm__gather_receiver_lanes(const rsm__gather *g, rsm__receiver_lanes *p, uint32_t set,
                                              rsm__tally *tally)
{
    size_t i, l;
    float rgb[3];
    int c;
    for (i = 0; i < g->source_count && p->count; i++) {
        const rsm__source *s = g->sources + i;
        if (s->blocks) g->lanes_kernel(s->blocks + set * s->set_blocks, s->set_lights, p);
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

/* Gathers for a row of a picture, set by set. */
static inline void rsm__gather_row(void *context, size_t y)
{
    const rsm__gather *g = (const rsm__gather *)context;
    rsm__tally *tally = g->tallies + y;
    size_t width = g->points->width, first = y * width,
           n = g->count - first < width ? g->count - first : width, x;
    uint32_t k = g->desc.interleave, column;
    rsm__receiver_lanes p;
    memset(tally, 0, sizeof *tally);
    memset(&p, 0, sizeof p);
    for (column = 0; column < k; column++) {
        uint32_t set = column + k * (uint32_t)(y % k);
        for (x = column; x < n; x += k) {
            rsm__receiver_lanes_add(g, &p, first + x, tally);
            if (p.count == g->receiver_lane_count) rsm__gather_receiver_lanes(g, &p, set, tally);
        }
        rsm__gather_receiver_lanes(g, &p, set, tally);
    }
}

static inline rsm_result rsm__materials_check(const rsm__logger *log, const rsm_gather_desc *d)
{
    uint32_t i;
    int c;
    if (!d->materials && d->material_count)
        return rsm__refuse(log, RSM_ERR_DESC, "desc.materials", "is NULL, and material_count is not 0");
    for (i = 0; i < d->material_count; i++) {
        const rsm_material *m = d->materials + i;
        if (!(m->exponent >= 0.0f && m->exponent <= 1e4f)) {
            rsm__log_element(log, "desc.materials", i, "has the exponent", (double)m->exponent, "0..1e4");
            return RSM_ERR_INPUT;
        }
        for (c = 0; c < 3; c++) {
            if (m->specular[c] >= 0.0f && m->specular[c] <= 1.0f) continue;
            rsm__log_element(log, "desc.materials", i, "has the specular", (double)m->specular[c], "0..1");
            return RSM_ERR_INPUT;
        }
    }
    return RSM_OK;
}

static inline rsm_result rsm__noise_check(const rsm__logger *log, const rsm_gather_desc *d)
{
    uint32_t i;
    if (!d->noise) return RSM_OK;
    if (!rsm__check_range(log, "desc.noise_side", d->noise_side, 1, 4096, "1..4096")) return RSM_ERR_DESC;
    for (i = 0; i < d->noise_side * d->noise_side; i++)
        if (!(d->noise[i] >= 0.0f && d->noise[i] <= 1.0f)) {
            rsm__log_element(log, "desc.noise", i, "is", (double)d->noise[i], "0..1");
            return RSM_ERR_INPUT;
        }
    return RSM_OK;
}

static inline rsm_result rsm__numbers_check(const rsm__logger *log, const rsm_gather_desc *d)
{
    const rsm_result bad = RSM_ERR_DESC;
    const int poisson = d->pattern == RSM_PATTERN_POISSON;
    if (!rsm__check_range(log, "desc.pattern", (double)d->pattern, 0, RSM_PATTERN_COUNT - 1,
                          "one of rsm_pattern"))
        return bad;
    if (!rsm__check_range(log, "desc.sample_count", d->sample_count, 0,
                          poisson ? RSM__MAX_POISSON : RSM__MAX_SAMPLES,
                     poisson ? "0..4096 with POISSON" : "0..2^20"))
        return bad;
    if (!rsm__check_range(log, "desc.r_max", (double)d->r_max, 0, 1e3, "0..1000")) return bad;
    if (!rsm__check_range(log, "desc.r_min", (double)d->r_min, 0, 0.99999994, "0 or more, below 1"))
        return bad;
    if (!rsm__check_range(log, "desc.offset", (double)d->offset, 0, 1e9, "0..1e9")) return bad;
    if (!rsm__check_range(log, "desc.clamp", (double)d->clamp, 0, (double)1e18f, "0..1e18")) return bad;
    if (!rsm__check_range(log, "desc.near_limit", (double)d->near_limit, 0, 1e6, "0..1e6")) return bad;
    if (!rsm__check_range(log, "desc.near_field", (double)d->near_field, 0, 32, "0..32")) return bad;
    if (d->interleave <= 8 && (d->interleave & (d->interleave - 1)) == 0) return RSM_OK;
    rsm__log_value(log, "desc.interleave", d->interleave, "0, 1, 2, 4 or 8");
    return bad;
}

/* Checks that lights have numbers where visible_fn wants them: those about each receiver have none. */
static inline rsm_result rsm__seeing_check(const rsm__logger *log, const rsm_gather_desc *d)
{
    if (!d->visible_fn || d->sample_count == 0 || d->pattern == RSM_PATTERN_FLUX) return RSM_OK;
    rsm__log_value(log, "desc.pattern", (double)d->pattern,
                   "RSM_PATTERN_FLUX with visible_fn, unless sample_count is 0");
    return RSM_ERR_DESC;
}

/* Checks a desc, which may be NULL, and writes it with its defaults to out. */
static inline rsm_result rsm__gather_check(const rsm__logger *log, const rsm_gather_desc *desc,
                                           const rsm_points *points, rsm_gather_desc *out)
{
    rsm_result result;
    memset(out, 0, sizeof *out);
    if (desc) *out = *desc;
    result = rsm__numbers_check(log, out);
    if (result == RSM_OK) result = rsm__noise_check(log, out);
    if (result == RSM_OK) result = rsm__materials_check(log, out);
    if (result != RSM_OK) return result;
    if (!rsm__system_valid(log, &out->system)) return RSM_ERR_DESC;
    if (out->pattern == RSM_PATTERN_DEFAULT) out->pattern = RSM_PATTERN_FLUX;
    if (!(out->r_min > 0.0f)) out->r_min = 1.0f / 32.0f;
    if (out->pattern == RSM_PATTERN_MIXED) {
        out->r_min = RSM__MIXED_MIN;
        out->r_max = 0.0f;
    }
    if (out->interleave == 0) out->interleave = 1;
    if (out->interleave == 1 || points->width != 0) return RSM_OK;
    rsm__log_value(log, "desc.interleave", out->interleave,
                   "0 or 1 if points.width is 0: one row is no picture");
    return RSM_ERR_DESC;
}

/* Gives back what rsm__gather_open and rsm__make_tallies allocated. */
static inline void rsm__gather_close(rsm__gather *g, const rsm__allocator *a)
{
    size_t i = g->sources ? g->source_count : 0;
    rsm__free(a, g->tallies);
    rsm__free(a, g->pattern);
    while (i-- > 0) {
        rsm__free(a, g->sources[i].reaches);
        rsm__free(a, g->sources[i].numbers);
        rsm__free(a, g->sources[i].gloss);
        rsm__free(a, g->sources[i].blocks);
    }
    rsm__free(a, g->sources);
}

/* Makes what all receivers share: sources, sets, the pattern. If it fails, the caller calls
   rsm__gather_close. */
static inline rsm_result rsm__gather_open(rsm__gather *g, const rsm_map *const *maps, size_t map_count,
                                          const rsm_texel *lights, size_t light_count,
                                          const rsm__allocator *a)
{
    size_t i;
    int list = maps == NULL, mixed = g->desc.pattern == RSM_PATTERN_MIXED && g->desc.sample_count > 1;
    rsm_result result = RSM_OK;
    g->source_count = list ? 1 : map_count;
    g->sets = g->desc.interleave * g->desc.interleave;
    g->scale = 1.0f / RSM__PI;
    g->shared = g->centred = g->set_samples = 0;
    if (!list && g->desc.sample_count) {
        g->centred = mixed ? 3u * g->desc.sample_count / 5u : g->desc.sample_count;
        if (g->desc.pattern == RSM_PATTERN_FLUX || (g->desc.pattern == RSM_PATTERN_MIXED && !mixed))
            g->centred = 0;
        g->shared = g->desc.sample_count - g->centred;
    }
    g->sources = (rsm__source *)rsm__alloc_array(a, g->source_count, sizeof *g->sources);
    if (!g->sources) return RSM_ERR_ALLOC;
    memset(g->sources, 0, g->source_count * sizeof *g->sources);
    if (g->centred) {
        uint32_t n, k;
        float *sorted;
        g->set_samples = (g->centred + g->sets - 1) / g->sets;
        n = g->set_samples * g->sets; /* rounded up to sets of the same size, so that every sample weighs the
                                         same; RSM__MAX_POISSON is a multiple of any number of sets */
        g->pattern = (float *)rsm__alloc_array(a, n, 3 * sizeof *g->pattern);
        sorted = (float *)rsm__alloc_array(a, n, 3 * sizeof *sorted);
        if (!g->pattern || !sorted) {
            rsm__free(a, sorted);
            return RSM_ERR_ALLOC;
        }
        g->centred = n;
        rsm__pattern_make(mixed ? RSM_PATTERN_LOG_RADIAL : g->desc.pattern, n, g->desc.r_min,
                          g->desc.paper_weights, g->desc.seed, sorted);
        for (k = 0; k < n; k++) { /* sample k goes to set k % sets */
            float *to = g->pattern + 3 * ((size_t)(k % g->sets) * g->set_samples + k / g->sets);
            memcpy(to, sorted + 3 * (size_t)k, 3 * sizeof *to);
        }
        rsm__free(a, sorted);
    }
    for (i = 0; i < g->source_count && result == RSM_OK; i++) {
        if (!list) g->sources[i].map = maps[i];
        if (list) result = rsm__pack_list(g, g->sources, lights, light_count, a);
        else if (g->shared || !g->desc.sample_count) result = rsm__pack_map(g, g->sources + i, a);
    }
    return result;
}

/* Adds the tallies of all tasks to the statistics. sums collects what shares are made of. */
static inline void rsm__gather_add_stats(const rsm__gather *g, size_t batches, rsm_gather_stats *stats,
                                         double sums[4])
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

static inline rsm_result rsm__maps_check(const rsm__logger *log, const rsm_map *const *maps, size_t map_count)
{
    size_t i;
    if (!maps) return rsm__refuse(log, RSM_ERR_ARGUMENT, "maps", "is NULL");
    if (map_count == 0) return rsm__refuse(log, RSM_ERR_ARGUMENT, "map_count", "is 0");
    for (i = 0; i < map_count; i++) {
        if (maps[i]) continue;
        rsm__log_element_text(log, "maps", i, "is NULL");
        return RSM_ERR_ARGUMENT;
    }
    for (i = 0; i < map_count; i++) {
        if (maps[i]->finished) continue;
        rsm__log_element_text(log, "maps", i, "is not finished: rsm_finish must come first");
        return RSM_ERR_ORDER;
    }
    return RSM_OK;
}

/* Logs why a gather failed after its arguments were checked, and returns the result. */
static inline rsm_result rsm__gather_logged(const rsm__logger *log, rsm_result result)
{
    if (result == RSM_ERR_ALLOC)
        rsm__log_text(log, "the allocator", "returned no memory for lights or receivers");
    if (result == RSM_ERR_CANCELLED) rsm__log_text(log, "progress", "cancelled the call");
    return result;
}

/* Returns how many tasks gather for so many receivers: rows of a picture, or batches. */
static inline size_t rsm__count_tasks(const rsm__gather *g, size_t count)
{
    size_t each = rsm__gathers_by_rows(g) ? g->points->width : (size_t)RSM__BATCH;
    return count / each + (count % each != 0);
}

/* Takes memory for the tallies of all tasks of an opened gather. If it fails, the caller calls
   rsm__gather_close. */
static inline rsm_result rsm__make_tallies(rsm__gather *g, const rsm__allocator *a)
{
    size_t batches = rsm__count_tasks(g, g->points->indices ? g->points->index_count : g->points->count);
    g->tallies = (rsm__tally *)rsm__alloc_array(a, batches + 1, sizeof *g->tallies);
    return g->tallies ? RSM_OK : RSM_ERR_ALLOC;
}

/* Gathers for the receivers of g->points. begin and end are the fractions of the whole call at which this
   part begins and ends. */
static inline rsm_result rsm__gather_points(rsm__gather *g, rsm_gather_stats *stats, float begin, float end)
{
    size_t batches;
    rsm_gather_stats s;
    double sums[4] = { 0, 0, 0, 0 };
    g->count = g->points->indices ? g->points->index_count : g->points->count;
    batches = rsm__count_tasks(g, g->count);
    if (!rsm__run_steps(&g->desc.system, batches,
                        rsm__gathers_by_rows(g) ? rsm__gather_row : rsm__gather_batch, g, begin, end))
        return RSM_ERR_CANCELLED;
    if (!stats) return RSM_OK;
    memset(&s, 0, sizeof s);
    rsm__gather_add_stats(g, batches, &s, sums);
    *stats = s;
    return RSM_OK;
}

/* Returns whether the light that bounds take off has to be summed. */
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
    g->lanes_kernel = rsm__choose_receiver_lanes_kernel(rsm__loss_wanted(g, stats), &g->receiver_lane_count);
    result = rsm__gather_open(g, maps, map_count, lights, light_count, &a);
    if (result == RSM_OK) result = rsm__make_tallies(g, &a);
    if (result == RSM_OK) result = rsm__gather_points(g, stats, 0.0f, 1.0f);
    rsm__gather_close(g, &a);
    return result;
}

RSM_DEF rsm_result rsm_gather(const rsm_map *const *maps, size_t map_count, const rsm_gather_desc *desc,
                              const rsm_points *points, float *irradiance, rsm_gather_stats *stats)
{
    const rsm_map *first = maps && map_count ? maps[0] : NULL;
    rsm__logger log = rsm__logger_of_map(desc ? &desc->system : NULL, first, "rsm_gather");
    rsm__gather g;
    rsm_result result = rsm__maps_check(&log, maps, map_count);
    memset(&g, 0, sizeof g);
    if (result == RSM_OK) result = rsm__points_check(&log, points, irradiance);
    if (result == RSM_OK) result = rsm__gather_check(&log, desc, points, &g.desc);
    if (result == RSM_OK) result = rsm__seeing_check(&log, &g.desc);
    if (result != RSM_OK) return result;
    g.points = points;
    g.out = irradiance;
    return rsm__gather_logged(&log, rsm__gather_run(&g, maps, map_count, NULL, 0, stats));
}

/* Checks a list of pixel lights. */
static inline rsm_result rsm__lights_check(const rsm__logger *log, const rsm_texel *lights, size_t count)
{
    size_t i;
    if (!lights && count) return rsm__refuse(log, RSM_ERR_ARGUMENT, "lights", "is NULL");
    for (i = 0; i < count; i++)
        if (!rsm__unit_or_none(lights[i].normal))
            return rsm__refuse_normal(log, "lights.normal", i, rsm__v3_load(lights[i].normal));
    return RSM_OK;
}

RSM_DEF rsm_result rsm_gather_list(const rsm_texel *lights, size_t count, const rsm_gather_desc *desc,
                                   const rsm_points *points, float *irradiance, rsm_gather_stats *stats)
{
    rsm__logger log = rsm__logger_of(desc ? &desc->system : NULL, "rsm_gather_list");
    rsm__gather g;
    rsm_result result = rsm__lights_check(&log, lights, count);
    memset(&g, 0, sizeof g);
    if (result == RSM_OK) result = rsm__points_check(&log, points, irradiance);
    if (result == RSM_OK) result = rsm__gather_check(&log, desc, points, &g.desc);
    if (result != RSM_OK) return result;
    g.desc.materials = NULL;
    g.desc.noise = NULL;
    g.points = points;
    g.out = irradiance;
    return rsm__gather_logged(&log, rsm__gather_run(&g, NULL, 0, lights, count, stats));
}

/* ==== src/rsm/lists.h ==== */

/* ---- lists of pixel lights, and clusters of them ---- */

RSM_DEF rsm_result rsm_pixel_lights(const rsm_map *const *maps, size_t map_count, uint32_t sample_count,
                                    uint32_t seed, rsm_texel *lights, size_t capacity, size_t *count)
{
    rsm__logger log =
        rsm__logger_of(maps && map_count && maps[0] ? &maps[0]->desc.system : NULL, "rsm_pixel_lights");
    size_t m, i, needed = 0, at = 0;
    rsm_result result = rsm__maps_check(&log, maps, map_count);
    if (result != RSM_OK) return result;
    if (!count) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "count", "is NULL");
    if (!lights && capacity) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "lights", "is NULL");
    if (!rsm__check_range(&log, "sample_count", sample_count, 0, RSM__MAX_SAMPLES, "0..2^20"))
        return RSM_ERR_ARGUMENT;
    for (m = 0; m < map_count; m++) {
        float weight;
        if (!sample_count) needed += (size_t)maps[m]->stats.lit_texels;
        for (i = 0; i < sample_count; i++)
            needed += (size_t)rsm__pick_texel(maps[m], (uint32_t)i, sample_count, seed, &at, &weight);
    }
    *count = needed;
    if (capacity < needed) {
        rsm__log_bound(&log, "capacity", capacity, "at least", needed, "which *count says");
        return RSM_ERR_MEMORY;
    }
    for (m = 0, needed = 0; m < map_count; m++)
        for (i = 0; i < (sample_count ? sample_count : rsm__texel_count(maps[m])); i++) {
            float weight = 1.0f;
            int c;
            at = i;
            if (sample_count ? !rsm__pick_texel(maps[m], (uint32_t)i, sample_count, seed, &at, &weight)
                        : !(rsm__mean3(maps[m]->texels[at].flux) > 0.0f))
                continue;
            lights[needed] = maps[m]->texels[at];
            lights[needed].area *= weight;
            for (c = 0; c < 3; c++) lights[needed].flux[c] *= weight;
            needed++;
        }
    return RSM_OK;
}

typedef struct rsm__group {        /* a group of lights: `count` entries of the order from `first` on */
    size_t first, count;
    double flux;
    double mean[6], spread[6];     /* of positions and normals, weighted by flux */
    double cost;                   /* flux x spread: the costliest group is cut next */
} rsm__group;

/* Returns coordinate k of a light: 0 to 2 of its position, 3 to 5 of its normal. */
static inline float rsm__coordinate(const rsm_texel *t, int k)
{
    return k < 3 ? t->position[k] : t->normal[k - 3];
}

/* Measures the means and spreads of a group, and its cost. Spreads of normals are scaled to those of
   positions by size2, the squared size of the scene. */
static inline void rsm__measure_group(rsm__group *g, const rsm_texel *lights, const uint32_t *order,
                                      double size2)
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

/* Cuts a group at the mean of its widest coordinate. Returns 0 if all lights fall on one side. */
static inline int rsm__cut_group(rsm__group *g, rsm__group *other, const rsm_texel *lights, uint32_t *order,
                                 double size2)
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
    rsm__measure_group(g, lights, order, size2);
    rsm__measure_group(other, lights, order, size2);
    return 1;
}

/* Writes the light that stands for a group. */
static inline void rsm__group_light(const rsm__group *g, const rsm_texel *lights, const uint32_t *order,
                                    rsm_texel *out)
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
    if (!(rsm__v3_length(normal) > 1e-6f))
        normal = rsm__v3_load(brightest->normal); /* since opposite normals cancel out */
    rsm__v3_store(out->normal, rsm__v3_normalize(normal));
}

RSM_DEF rsm_result rsm_cluster(const rsm_texel *lights, size_t light_count, uint32_t cluster_count,
                               const rsm_system *system, rsm_texel *clusters, size_t *count)
{
    rsm__logger log;
    rsm_system none;
    rsm__allocator a;
    rsm_result result;
    rsm__group *groups;
    uint32_t *order, found = 1, i;
    uint32_t k, most;
    size_t used = 0, at;
    double size2 = 0.0;
    memset(&none, 0, sizeof none);
    if (!system) system = &none;
    log = rsm__logger_of(system, "rsm_cluster");
    if (!clusters) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "clusters", "is NULL");
    if (!count) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "count", "is NULL");
    if (!rsm__check_range(&log, "cluster_count", cluster_count, 1, 65536, "1..65536"))
        return RSM_ERR_ARGUMENT;
    if (!rsm__check_range(&log, "light_count", (double)light_count, 0, 0x7fffffff, "below 2^31"))
        return RSM_ERR_LIMIT;
    if (!rsm__system_valid(&log, system)) return RSM_ERR_DESC;
    result = rsm__lights_check(&log, lights, light_count);
    if (result != RSM_OK) return result;
    a = rsm__allocator_of(system);
    order = (uint32_t *)rsm__alloc_array(&a, light_count + 1, sizeof *order);
    groups = (rsm__group *)rsm__alloc_array(&a, cluster_count, sizeof *groups);
    if (!order || !groups) {
        rsm__free(&a, groups);
        rsm__free(&a, order);
        return rsm__refuse(&log, RSM_ERR_ALLOC, "the allocator", "returned no memory for groups of lights");
    }
    for (at = 0; at < light_count; at++) {
        float f = rsm__mean3(lights[at].flux);
        if (f > 0.0f && f <= 1e18f && rsm__is_usable(rsm__v3_load(lights[at].position)) &&
            rsm__is_usable(rsm__v3_load(lights[at].normal)))
            order[used++] = (uint32_t)at;
    }
    groups[0].first = 0;
    groups[0].count = used;
    rsm__measure_group(groups, lights, order, 0.0);
    for (k = 0; k < 3; k++) size2 += groups[0].spread[k];
    rsm__measure_group(groups, lights, order, size2);
    while (used && found < cluster_count) {
        most = 0;
        for (i = 1; i < found; i++)
            if (groups[i].cost > groups[most].cost) most = i;
        if (!(groups[most].cost > 0.0)) break;
        if (rsm__cut_group(groups + most, groups + found, lights, order, size2)) found++;
        else groups[most].cost = 0.0;
    }
    for (i = 0; used && i < found; i++) rsm__group_light(groups + i, lights, order, clusters + i);
    *count = used ? found : 0;
    rsm__free(&a, groups);
    rsm__free(&a, order);
    return RSM_OK;
}

/* ==== src/rsm/interpolation.h ==== */

/* ---- interpolation: pictures by grids of samples (section 4) ---- */

typedef struct rsm__grid {
    const rsm_points       *points;
    const rsm_interpolation *desc;
    float    *out;
    uint8_t  *state;               /* of each pixel, see below */
    uint32_t *list;                /* the pixels that are evaluated next */
    uint32_t  width, height, step; /* pixels; step is that of this level's grid */
    int       lossy;               /* not 0: the light that bounds take off is summed */
    rsm__suit_kernel suit;
    float    *reach2;              /* of each sample the squared distance of its nearest light */
    float     limits[3];           /* the least cosine, the largest slope^2 and distance^2 of a sample that
                                      suits a pixel */
} rsm__grid;

/* The states of a pixel. States that are still pending have bit 0 set, and no other state has, so that eight
   pixels of a cell can be asked at a time. */
enum {
    RSM__NONE = 0,                 /* no receiver */
    RSM__BAD = 2,                  /* no receiver, since it is not finite */
    RSM__PENDING = 1,              /* a receiver without a result as yet */
    RSM__WANTED = 3,               /* the same, to be evaluated as a corner of a cell */
    RSM__INTERPOLATED = 4,
    RSM__REPLACED = 6,             /* interpolated, and to be evaluated as a corner of a cell */
    RSM__EVALUATED = 8
};

/* Writes the grid lines on both sides of a coordinate. Lines lie at the multiples of step, a power of two,
   and at the picture's last pixel. */
static inline void rsm__grid_lines(uint32_t at, uint32_t step, uint32_t size, uint32_t line[2])
{
    line[0] = at & ~(step - 1u);
    line[1] = line[0] + step < size ? line[0] + step : size - 1;
}

/* Returns where a coordinate lies between two lines, 0..1. */
static inline float rsm__grid_share(uint32_t at, const uint32_t line[2])
{
    return line[1] > line[0] ? (float)(at - line[0]) / (float)(line[1] - line[0]) : 0.0f;
}

enum { RSM__ALL_SUIT = 4 };        /* in place of the number of the missing sample, if all four suit */

typedef struct rsm__cell {
    uint32_t column[2], row[2];    /* of its corners */
    float    samples[4][6];        /* positions and normals of the corners */
    float    rgb[4][3];            /* light at the corners */
    float    limits[4][3];         /* those of rsm__grid, for each corner */
    int      there;                /* bits of the corners that were evaluated */
    int      agree[5];             /* agree[k]: the corners without corner k are alike; agree[4]: all are */
} rsm__cell;

/* Returns whether all corners but the missing one were evaluated and are alike in brightness. */
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

/* Loads the samples at the corners of a cell. Returns 0 if no pixel can be interpolated from them. */
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
        rsm__v3_store(cell->samples[k], rsm__vector_at(p->positions, p->position_stride, at[k]));
        rsm__v3_store(cell->samples[k] + 3, rsm__vector_at(p->normals, p->normal_stride, at[k]));
        memcpy(cell->rgb[k], g->out + 3 * at[k], 12);
        memcpy(cell->limits[k], g->limits, sizeof g->limits);
        if (g->desc->light_share > 0.0f &&
            g->reach2[at[k]] * g->desc->light_share * g->desc->light_share < cell->limits[k][2])
            cell->limits[k][2] = g->reach2[at[k]] * g->desc->light_share * g->desc->light_share;
    }
    return any;
}

/* Writes the bilinear value at (u, v) of a cell. A missing sample counts as the sum of its neighbours less
   the one across, which makes the four a plane. The paper normalises the other weights in its place, which
   pulls the result towards these three, by 6 % at a crease (T39). */
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
        float x =
            w[0] * cell->rgb[0][c] + w[1] * cell->rgb[1][c] + w[2] * cell->rgb[2][c] + w[3] * cell->rgb[3][c];
        out[c] = x > 0.0f ? x : 0.0f;
    }
}

/* Interpolates those pixels of a tile for which three of the cell's samples suit, or all four: the rule of
   section 4. */
static inline void rsm__tile_interpolate(rsm__grid *g, const rsm__cell *cell, rsm__tile *t, size_t count)
{
    size_t i, end = (count + 7) & ~(size_t)7;
    int k;
    for (i = count; i < end; i++) t->px[i] = t->py[i] = t->pz[i] = t->nx[i] = t->ny[i] = t->nz[i] = 0.0f;
    memset(t->good, 0, end * sizeof *t->good);
    for (k = 0; k < 4; k++)
        if (cell->there >> k & 1) g->suit(t, end, cell->samples[k], cell->limits[k], 1 << k);
    for (i = 0; i < count; i++) {
        static const int8_t missing_of[16] = { -1, -1, -1, -1, -1, -1, -1, 3,
                                               -1, -1, -1, 2,  -1, 1,  0,  RSM__ALL_SUIT };
        size_t at = (size_t)t->y[i] * g->width + t->x[i];
        int missing = missing_of[t->good[i]];
        if (missing < 0 || !cell->agree[missing]) continue;
        rsm__cell_value(cell, missing, rsm__grid_share(t->x[i], cell->column),
                        rsm__grid_share(t->y[i], cell->row), g->out + 3 * at);
        g->state[at] = RSM__INTERPOLATED;
    }
}

/* Returns whether a cell has a pixel without a result. */
static inline int rsm__cell_pending(const rsm__grid *g, uint32_t left, uint32_t top, uint32_t right,
                                 uint32_t bottom)
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

/* Adds the pending pixels of a row to the tile, which has room for all of the row, and returns the new count.
   Every pixel is written, and a pending one moves the end on: a branch would be mispredicted, since which
   pixels are pending follows no pattern. */
static inline size_t rsm__tile_add(const rsm__grid *g, rsm__tile *t, size_t count, uint32_t left,
                                   uint32_t right, uint32_t y)
{
    const rsm_points *p = g->points;
    size_t first = (size_t)y * g->width + left, ps = rsm__stride_or(p->position_stride, 12),
           ns = rsm__stride_or(p->normal_stride, 12);
    const float *position = rsm__element_at(p->positions, ps, first);
    const float *normal = rsm__element_at(p->normals, ns, first);
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
        count += *state++ == RSM__PENDING;
        position = rsm__element_at(position, ps, 1);
        normal = rsm__element_at(normal, ns, 1);
    }
    return count;
}

/* Interpolates the pending pixels of a cell, a tile of them at a time. */
static inline void rsm__interpolate_cell(rsm__grid *g, rsm__tile *tile, uint32_t left, uint32_t top,
                                         uint32_t right, uint32_t bottom)
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

/* Interpolates a row of cells. Corners are looked at only if a cell has pending pixels, since another thread
   may be writing the state of others. */
static inline void rsm__interpolate_cells(void *context, size_t number)
{
    rsm__grid *g = (rsm__grid *)context;
    uint32_t x, top = (uint32_t)number * g->step,
                bottom = g->height - top < g->step ? g->height : top + g->step;
    rsm__tile tile;
    for (x = 0; x < g->width; x += g->step) {
        uint32_t right = g->width - x < g->step ? g->width : x + g->step;
        if (rsm__cell_pending(g, x, top, right, bottom))
            rsm__interpolate_cell(g, &tile, x, top, right, bottom);
        if (right == g->width) break;
    }
}

/* Marks the corners of the cell at (x, y) as wanted, unless they were evaluated before. A pixel that an
   earlier level interpolated is wanted too: an evaluated value replaces the interpolated one. */
static inline void rsm__want_corners(rsm__grid *g, uint32_t x, uint32_t y)
{
    uint32_t column[2], row[2], k;
    rsm__grid_lines(x, g->step, g->width, column);
    rsm__grid_lines(y, g->step, g->height, row);
    for (k = 0; k < 4; k++) {
        uint8_t *s = g->state + (size_t)row[k >> 1] * g->width + column[k & 1];
        if (*s == RSM__PENDING) *s = RSM__WANTED;
        else if (*s == RSM__INTERPOLATED) *s = RSM__REPLACED;
    }
}

/* Returns the grid line after `at`, or size if there is none. */
static inline uint32_t rsm__next_line(const rsm__grid *g, uint32_t at, uint32_t size)
{
    return at + g->step < size ? at + g->step : at + 1 < size ? size - 1 : size;
}

/* Lists the pixels that this level evaluates, marks them as evaluated, and returns how many they are: the
   corners of cells with pending pixels, or on the last level, whose step is 1, all pending pixels. */
static inline size_t rsm__list_wanted(rsm__grid *g)
{
    uint32_t x, y;
    size_t found = 0;
    for (y = 0; y < g->height && g->step > 1; y += g->step)
        for (x = 0; x < g->width; x += g->step) {
            uint32_t right = g->width - x < g->step ? g->width : x + g->step,
                     bottom = g->height - y < g->step ? g->height : y + g->step;
            if (rsm__cell_pending(g, x, y, right, bottom)) rsm__want_corners(g, x, y);
        }
    for (y = 0; y < g->height; y = rsm__next_line(g, y, g->height))
        for (x = 0; x < g->width; x = rsm__next_line(g, x, g->width)) {
            size_t at = (size_t)y * g->width + x;
            uint8_t state = g->state[at];
            if (g->step > 1 ? state != RSM__WANTED && state != RSM__REPLACED : state != RSM__PENDING)
                continue;
            g->state[at] = RSM__EVALUATED;
            g->list[found++] = (uint32_t)at;
        }
    return found;
}

/* Checks settings, which may be NULL, and writes them with their defaults to out. */
static inline rsm_result rsm__interpolation_check(const rsm__logger *log, const rsm_interpolation *d,
                                                  rsm_interpolation *out)
{
    const rsm_result bad = RSM_ERR_DESC;
    memset(out, 0, sizeof *out);
    if (d) *out = *d;
    if (out->step == 0) out->step = 8;
    if (out->step < 2 || out->step > 64 || (out->step & (out->step - 1))) {
        rsm__log_value(log, "interpolation.step", out->step, "0 or a power of two, 2..64");
        return bad;
    }
    if (!rsm__check_range(log, "interpolation.level_count", out->level_count, 0, 6, "0..6")) return bad;
    if (!rsm__check_range(log, "interpolation.normal_cosine", (double)out->normal_cosine, -1, 1, "-1..1"))
        return bad;
    if (!rsm__check_range(log, "interpolation.plane_slope", (double)out->plane_slope, 0, 1e6, "0..1e6"))
        return bad;
    if (!rsm__check_range(log, "interpolation.distance", (double)out->distance, 0, 1e9, "0..1e9")) return bad;
    if (!rsm__check_range(log, "interpolation.contrast", (double)out->contrast, -1e6, 1e6, "-1e6..1e6"))
        return bad;
    if (!rsm__check_range(log, "interpolation.light_share", (double)out->light_share, -1e6, 1e6, "-1e6..1e6"))
        return bad;
    if (out->level_count == 0) out->level_count = 6;
    if (!(fabsf(out->normal_cosine) > 0.0f)) out->normal_cosine = 0.95f;
    if (!(out->plane_slope > 0.0f)) out->plane_slope = 0.05f;
    if (!(fabsf(out->contrast) > 0.0f)) out->contrast = 0.25f;
    if (!(fabsf(out->light_share) > 0.0f)) out->light_share = 0.25f;
    return RSM_OK;
}

/* Runs one level: evaluates the grid of g->step (1: every pixel that is left), then interpolates the pixels
   for which samples suit. begin and end are the fractions of the whole call at which this level begins and
   ends. */
static inline rsm_result rsm__grid_level(rsm__grid *g, rsm__gather *gather, rsm_gather_stats *total,
                                         float begin, float end)
{
    rsm_points points = *g->points;
    rsm_gather_stats stats;
    rsm_result result;
    points.indices = g->list;
    points.index_count = rsm__list_wanted(g);
    points.open = NULL; /* rsm__grid_finish applies it, at full resolution */
    if (points.index_count == 0) return RSM_OK;
    gather->points = &points;
    gather->reach2 = g->step > 1 && g->desc->light_share > 0.0f ? g->reach2 : NULL;
    gather->kernel = rsm__choose_kernel(g->lossy, gather->reach2 != NULL);
    result = rsm__gather_points(gather, &stats, begin, end);
    gather->points = g->points;
    if (result != RSM_OK) return result;
    total->evaluated += stats.evaluated;
    total->pairs += stats.pairs;
    total->clamped_share += stats.clamped_share * (double)stats.evaluated;
    total->outside_share += stats.outside_share * (double)stats.evaluated;
    if (g->step > 1)
        rsm__run_tasks(&gather->desc.system, (g->height + g->step - 1) / g->step, rsm__interpolate_cells, g);
    return RSM_OK;
}

/* Writes the mask, multiplies all pixels by what is open there, and returns the number of bad points. */
static inline uint64_t rsm__grid_finish(rsm__grid *g, uint8_t *mask)
{
    const rsm_points *p = g->points;
    uint64_t bad = 0;
    size_t at, pixels = (size_t)g->width * g->height;
    int c;
    for (at = 0; at < pixels; at++) bad += g->state[at] == RSM__BAD;
    for (at = 0; at < pixels && mask; at++) mask[at] = g->state[at] / RSM__INTERPOLATED;
    for (at = 0; at < pixels && p->open; at++) {
        float f;
        if (g->state[at] < RSM__INTERPOLATED) continue;
        f = *rsm__element_at(p->open, rsm__stride_or(p->open_stride, 4), at);
        f = f > 0.0f ? f < 1.0f ? f : 1.0f : 0.0f;
        for (c = 0; c < 3; c++) g->out[3 * at + (size_t)c] *= f;
    }
    return bad;
}

/* Sets the states of a row before the first level. */
static inline void rsm__grid_start_row(void *context, size_t y)
{
    rsm__grid *g = (rsm__grid *)context;
    size_t at;
    for (at = y * g->width; at < (y + 1) * g->width; at++) {
        rsm__v3 x, n;
        uint64_t bad = 0;
        int lit = rsm__load_receiver(g->points, at, &x, &n, &bad);
        g->state[at] = lit ? RSM__PENDING : bad ? RSM__BAD : RSM__NONE;
        if (!lit) memset(g->out + 3 * at, 0, 3 * sizeof *g->out);
    }
}

/* Runs all levels, from the coarsest grid to single pixels. */
static inline rsm_result rsm__interpolate_all(rsm__grid *g, rsm__gather *gather, uint32_t levels,
                                              rsm_gather_stats *total)
{
    uint32_t level, steps = 0;
    rsm_result result = RSM_OK;
    while (steps < levels && g->step >> steps > 1u) steps++;
    rsm__run_tasks(&gather->desc.system, g->height, rsm__grid_start_row, g);
    for (level = 0; level <= steps && result == RSM_OK; level++, g->step /= 2) {
        float begin = (float)level / (float)(steps + 1u), end = (float)(level + 1u) / (float)(steps + 1u);
        if (level == steps) g->step = 1;
        result = rsm__grid_level(g, gather, total, begin, end);
    }
    return result;
}

/* Checks a call's picture, gather and interpolation, and fills in defaults. */
static inline rsm_result rsm__picture_check(const rsm__logger *log, const rsm_points *points,
                                            const float *out, const rsm_gather_desc *desc,
                                            const rsm_interpolation *interpolation, rsm_gather_desc *gather,
                                            rsm_interpolation *how)
{
    rsm_result result = rsm__points_check(log, points, out);
    if (result != RSM_OK) return result;
    if (points->indices)
        return rsm__refuse(log, RSM_ERR_ARGUMENT, "points.indices", "is not NULL, as it must be here");
    if (points->width == 0 || points->count % points->width != 0 || points->count > 0xffffffffu) {
        rsm__log_value(log, "points.width", points->width,
                       "the pixels in a row, of which points.count is a multiple");
        return RSM_ERR_ARGUMENT;
    }
    result = rsm__gather_check(log, desc, points, gather);
    if (result == RSM_OK) result = rsm__seeing_check(log, gather);
    if (result == RSM_OK) result = rsm__interpolation_check(log, interpolation, how);
    if (result != RSM_OK) return result;
    if (gather->noise) return rsm__refuse(log, RSM_ERR_DESC, "desc.noise", "is not NULL, as it must be here");
    if (!rsm__check_range(log, "desc.interleave", gather->interleave, 1, 1, "0 or 1 here"))
        return RSM_ERR_DESC;
    if (!rsm__check_range(log, "desc.add", gather->add, 0, 0, "0 here")) return RSM_ERR_DESC;
    return RSM_OK;
}

/* Allocates what the levels need, runs them, and fills in the statistics. */
static inline rsm_result rsm__interpolate_run(rsm__grid *g, rsm__gather *gather, const rsm_map *const *maps,
                                              size_t map_count, rsm_gather_stats *stats)
{
    rsm__allocator a = rsm__allocator_of(&gather->desc.system);
    const size_t count = gather->points->count;
    rsm_gather_stats total;
    rsm_result result;
    memset(&total, 0, sizeof total);
    g->list = (uint32_t *)rsm__alloc_array(&a, count + 1, sizeof *g->list);
    g->state = (uint8_t *)rsm__alloc_array(&a, count + 1, 1);
    g->reach2 = (float *)rsm__alloc_array(&a, count + 1, sizeof *g->reach2);
    result = g->list && g->state && g->reach2 ? rsm__gather_open(gather, maps, map_count, NULL, 0, &a)
                                              : RSM_ERR_ALLOC;
    if (result == RSM_OK) result = rsm__make_tallies(gather, &a); /* all memory is there before levels write
                                                                     */
    if (result == RSM_OK) result = rsm__interpolate_all(g, gather, g->desc->level_count, &total);
    rsm__gather_close(gather, &a);
    if (result == RSM_OK) {
        total.bad_points = rsm__grid_finish(g, g->desc->mask);
        if (total.evaluated) {
            total.clamped_share /= (double)total.evaluated;
            total.outside_share /= (double)total.evaluated;
        }
        if (stats) *stats = total;
    }
    rsm__free(&a, g->reach2);
    rsm__free(&a, g->state);
    rsm__free(&a, g->list);
    return result;
}

RSM_DEF rsm_result rsm_interpolate(const rsm_map *const *maps, size_t map_count, const rsm_gather_desc *desc,
                                   const rsm_interpolation *interpolation, const rsm_points *points,
                                   float *irradiance, rsm_gather_stats *stats)
{
    const rsm_map *first = maps && map_count ? maps[0] : NULL;
    rsm__logger log = rsm__logger_of_map(desc ? &desc->system : NULL, first, "rsm_interpolate");
    rsm__gather gather;
    rsm__grid g;
    rsm_interpolation how;
    rsm_result result = rsm__maps_check(&log, maps, map_count);
    memset(&gather, 0, sizeof gather);
    memset(&g, 0, sizeof g);
    if (result == RSM_OK)
        result = rsm__picture_check(&log, points, irradiance, desc, interpolation, &gather.desc, &how);
    if (result != RSM_OK) return result;
    g.points = gather.points = points;
    g.desc = &how;
    g.out = gather.out = irradiance;
    g.width = points->width;
    g.height = (uint32_t)(points->count / points->width);
    g.step = how.step;
    g.suit = rsm__choose_suit();
    g.limits[0] = how.normal_cosine;
    g.limits[1] = how.plane_slope * how.plane_slope;
    g.limits[2] = how.distance > 0.0f ? how.distance * how.distance : RSM_FAR;
    g.lossy = rsm__loss_wanted(&gather, stats);
    return rsm__gather_logged(&log, rsm__interpolate_run(&g, &gather, maps, map_count, stats));
}

/* ==== src/rsm/direct.h ==== */

/* ---- direct light, shadowed by the same map (section 4) ---- */

typedef struct rsm__direct {
    const rsm_map    *map;
    rsm_direct_desc   desc;
    const rsm_points *points;
    float            *out;
} rsm__direct;

/* Returns the irradiance at p without shadow, for a light of value 1. It is 0 outside of a cone and behind a
   patch. */
static inline float rsm__unshadowed_light(const rsm_map *map, rsm__v3 p, rsm__v3 n, rsm__v3 to_light)
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

/* Returns the lit share of tap_side x tap_side texels about p, weighted as by a box whose place is not bound
   to texels. With 2 x 2 the weights are bilinear. */
static inline float rsm__lit_share(const rsm_map *map, const rsm_direct_desc *desc, rsm__v3 p, float cosine)
{
    uint32_t face = rsm__face_of(map, p);
    rsm__v3 q = rsm__to_face(map, face, p);
    float side = (float)map->side, radius = 0.5f * (float)(desc->tap_side - 1);
    float x, y, texel;
    float bias, slope, sum = 0.0f, total = 0.0f;
    float fx, fy;
    uint32_t i, j;
    if (face >= map->faces) return 0.0f;
    if (!rsm__is_sun(map) && !(q.z > 0.0f)) return 0.0f;
    if (!(fabsf(q.x) <= 1.0f && fabsf(q.y) <= 1.0f)) return rsm__is_sun(map) ? 1.0f : 0.0f;
    texel = 2.0f / side * map->extent * (rsm__is_sun(map) ? 1.0f : q.z);
    slope = cosine < 1.0f ? sqrtf(1.0f - cosine * cosine) / (cosine > 0.1f ? cosine : 0.1f) : 0.0f;
    slope = slope < 10.0f ? slope : 10.0f;
    bias = texel * (desc->bias +
                    desc->slope_bias * slope * 0.7072f * (float)desc->tap_side); /* the farthest tap */
    x = (q.x * 0.5f + 0.5f) * side - radius; /* floor(x) is the column of the first tap */
    y = (q.y * 0.5f + 0.5f) * side - radius;
    fx = x - floorf(x);
    fy = y - floorf(y);
    for (j = 0; j < desc->tap_side; j++)
        for (i = 0; i < desc->tap_side; i++) {
            int32_t s = (int32_t)floorf(x) + (int32_t)i, t = (int32_t)floorf(y) + (int32_t)j;
            float weight = (i == 0                ? 1.0f - fx
                            : i == desc->tap_side - 1 ? fx
                                                  : 1.0f) *
                           (j == 0                ? 1.0f - fy
                            : j == desc->tap_side - 1 ? fy
                                                  : 1.0f);
            if (desc->tap_side == 1) weight = 1.0f;
            total += weight;
            s = s < 0 ? 0 : s >= (int32_t)map->side ? (int32_t)map->side - 1 : s;
            t = t < 0 ? 0 : t >= (int32_t)map->side ? (int32_t)map->side - 1 : t;
            if (q.z - bias <=
                map->texels[((size_t)face * map->side + (size_t)t) * map->side + (size_t)s].depth)
                sum += weight;
        }
    return total > 0.0f ? sum / total : 0.0f;
}

/* Lights a batch of 256 receivers. */
static inline void rsm__direct_batch(void *context, size_t batch)
{
    const rsm__direct *w = (const rsm__direct *)context;
    const rsm_points *p = w->points;
    size_t count = p->indices ? p->index_count : p->count, i = batch * 256,
           end = i + 256 < count ? i + 256 : count;
    for (; i < end; i++) {
        size_t at = p->indices ? p->indices[i] : i;
        float light = 0.0f, *out = w->out + 3 * at;
        rsm__v3 x, n;
        uint64_t bad = 0;
        int c;
        if (rsm__load_receiver(p, at, &x, &n, &bad)) {
            rsm__v3 to_light = rsm__to_light(w->map, x);
            light = rsm__unshadowed_light(w->map, x, n, to_light);
            if (light > 0.0f) light *= rsm__lit_share(w->map, &w->desc, x, rsm__v3_dot(n, to_light));
        }
        for (c = 0; c < 3; c++) out[c] = (w->desc.add ? out[c] : 0.0f) + light * w->map->desc.light.value[c];
    }
}

/* Checks a desc, which may be NULL, and writes it with its defaults to out. */
static inline rsm_result rsm__direct_check(const rsm__logger *log, const rsm_direct_desc *desc,
                                           rsm_direct_desc *out)
{
    memset(out, 0, sizeof *out);
    if (desc) *out = *desc;
    if (!rsm__check_range(log, "desc.tap_side", out->tap_side, 0, 15, "0..15")) return RSM_ERR_DESC;
    if (!rsm__check_range(log, "desc.bias", (double)out->bias, -1e6, 1e6, "-1e6..1e6")) return RSM_ERR_DESC;
    if (!rsm__check_range(log, "desc.slope_bias", (double)out->slope_bias, -1e6, 1e6, "-1e6..1e6"))
        return RSM_ERR_DESC;
    if (!rsm__system_valid(log, &out->system)) return RSM_ERR_DESC;
    if (out->tap_side == 0) out->tap_side = 2;
    if (out->bias == 0.0f) out->bias = 0.5f;
    if (out->slope_bias == 0.0f) out->slope_bias = 1.0f;
    out->bias = out->bias > 0.0f ? out->bias : 0.0f;
    out->slope_bias = out->slope_bias > 0.0f ? out->slope_bias : 0.0f;
    return RSM_OK;
}

RSM_DEF rsm_result rsm_direct(const rsm_map *map, const rsm_direct_desc *desc, const rsm_points *points,
                              float *irradiance)
{
    rsm__logger log = rsm__logger_of_map(desc ? &desc->system : NULL, map, "rsm_direct");
    rsm__direct w;
    size_t count;
    rsm_result result;
    if (!map) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "map", "is NULL");
    if (!map->finished)
        return rsm__refuse(&log, RSM_ERR_ORDER, "map", "is not finished: rsm_finish must come first");
    result = rsm__points_check(&log, points, irradiance);
    if (result == RSM_OK) result = rsm__direct_check(&log, desc, &w.desc);
    if (result != RSM_OK) return result;
    w.map = map;
    w.points = points;
    w.out = irradiance;
    count = points->indices ? points->index_count : points->count;
    if (!rsm__run_steps(&w.desc.system, (count + 255) / 256, rsm__direct_batch, &w, 0.0f, 1.0f))
        return rsm__refuse(&log, RSM_ERR_CANCELLED, "progress", "cancelled the call");
    return RSM_OK;
}

/* ==== src/shared/fp_end.h ==== */

/* unit fp_end: the user's options again. clang and MSVC keep contraction off to the end of the file. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__)
#pragma GCC pop_options
#endif

/* ==== src/rsm/end.h ==== */

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

For more information, please refer to
<https://unlicense.org/> */
