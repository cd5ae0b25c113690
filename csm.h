/* csm.h - v1.0.0 - coherent shadow maps: precomputed visibility of rigid objects - MIT-0 OR Unlicense

   What it does

   Renders an object's depth from thousands of directions (or light positions) once, compresses all those
   shadow maps into one small block, and answers "is this point lit from there?" with one cache line a query.
   The method is that of Ritschel, Grosch, Kautz and Mueller, "Interactive Illumination with Coherent Shadow
   Maps", EGSR 2007. lightsampling.h has what a Monte Carlo renderer of direct light needs around visibility:
   lights, materials, sampling.

   What it does not do

   - It does not deform objects. They are rigid; they may move, turn and scale evenly.
   - Its answers are exact for the maps, not for the scene: directions snap to N maps, and points to M x M
     pixels. Shadows of details finer than a pixel (1/128 of the object by default) are lost or widened;
     docs/csm.md has pictures and figures.
   - It computes no bounced light, renders no pictures, opens no files and starts no threads.

   Quick start

   Write the define in exactly one source file; include the header alone everywhere else.

       #define CSM_IMPLEMENTATION
       #include "csm.h"
       #include <stdio.h>

       int main(void)
       {
           static const float corners[] = { -1, 0, -1,  1, 0, -1,  1, 0, 1,  -1, 0, 1 };    // a square
           static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2 };
           const float point[3] = { 0.0f, -0.5f, 0.0f }, sideways[3] = { 1, 0, 0 }, up[3] = { 0, 1, 0 };
           cohsm_mesh mesh = { corners, 4, 0, triangles, 6, NULL, NULL, NULL };
           static cohsm_query query;                                 // static: all zero, the defaults
           cohsm_maps *maps;
           float lit[2];

           if (cohsm_build(NULL, &mesh, &maps, NULL) != COHSM_OK) return 1;     // 128 x 128 directions
           query.positions = point;
           query.count = 1;
           query.lights = up;                                                   // towards the light
           cohsm_visible(maps, &query, &lit[0], NULL);
           query.lights = sideways;
           cohsm_visible(maps, &query, &lit[1], NULL);
           printf("below the square: light from above %g, from the side %g\n", (double)lit[0],
                  (double)lit[1]);
           cohsm_free(maps);
           return !(lit[0] == 0.0f && lit[1] == 1.0f);
       }

   Real programs ask for thousands of points at once: the searches of a batch overlap, and one light for all
   points (query.one_light) is several times faster still.

   Conventions

   Coordinates are right-handed; matrices are column-major float[16]; distances are in the mesh's units,
   angles in radians. Directions point from the surface to the light: those of a query may have any length
   but 0, and those that cohsm_location writes are unit. The poles of the maps of directions are +Y and -Y:
   turn a scene whose up is Z before it comes here.

     map        the depths of the object along one direction (an orthographic image), or around one position
                (the six faces of a cube)
     domain     the set of those directions or positions: a mapping D of d parameters, each in 0..1
     cell       one of the N samples of the domain; each cell has one map
     view       one rendered image: a map of a direction, or one face of a map of a position. Views are stored
                in a sequence in which neighbours look alike
     layers     z1, z2, z3: the depths of the first, second and third hit of a pixel's ray
     segment    a run of views for which one stored depth separates z1 from the layer behind it
     tray       in the fast layout (COHSM_LAYOUT_FAST) the depths of one pixel over 256 views, within one
                cache line if they fit
     receiver   a point that may be lit, about which a query asks
     semi-local a light at a position outside the object's convex hull, answered by the maps of directions
     hull       the convex hull of the object, kept as a k-DOP (discrete oriented polytope): the solid between
                pairs of parallel planes, here of 13 fixed directions, that encloses the object

   How it works

   A pixel's depth z may be stored as any value in [z1, z2), since the comparison with a receiver on a surface
   comes out the same. For each pixel, the builder walks through the views and keeps one value as long as the
   value fits; this gives the least number of segments. A segment then takes 14 to 16 bits:

     lookup        4 bytes a pixel          directory     2 bytes a line, which has about 30 segments
     lines         64 bytes: where each segment begins (Elias-Fano), and its depth (8-bit grid, range or
                   palette)

   A block takes about 1.9 M^2 s bytes for s segments a pixel. s grows with about N^0.55 and with the object's
   detail: it is 345 for the bunny and 530 for the dragon at N = 128^2, M = 128. The knobs, and what each
   trades:

     side          Fewer directions make smaller blocks, but show as bands in penumbrae and as shadows that
                   jump while a light moves.
     map_side      Fewer pixels make smaller blocks, but jagged and widened contact shadows, and light leaks
                   through things thinner than a pixel. A face of a map of a position spans 90 degrees with M
                   pixels, so that few of them see a small object far from its light: make maps of directions
                   for such an object.
     layers        Z1Z2 is right everywhere. For closed objects, Z1Z3_SPHERE makes the block about half and
                   Z1Z3_FAR about a third as large, but both leak light onto receivers between the second and
                   the third surface, and Z1Z3_FAR also onto receivers behind the object.
     layout        FAST answers random queries 1.2 to 2 times as fast as COMPACT, since it decodes nothing. It
                   keeps trays of about 1.4 times the block's bytes beside the block.
     bias          Too little gives acne at grazing light, too much leaks light in corners. 1 pixel suits most
                   objects.
     filter        NEAREST is fastest, and jagged. PCF is smooth, and 10 times slower for maps of directions.
                   ROULETTE is as fast as NEAREST and has PCF's mean, but shows noise in place of jags.

   From the paper to the code

     section 3, figure 2    N maps of M x M pixels               cohsm_desc, cohsm_get_info           T63
     section 3.1, figure 3  a depth in [z1, z2) answers as z1    cohsm__interval                      T59, T71
     eq. (1), figure 4      segments: one depth for many maps    cohsm__compress_view, cohsm_verify   T59, T60
     section 3.1            z_avg; depths are linear             cohsm__choose_value, cohsm_depths    T59
     section 3.1            third layer, spherical far plane     cohsm_layers, cohsm__leave_depth     T62
     section 3.2, figure 6  project, find segment, compare       cohsm__project_point, cohsm__lit_at  T61, T66
     section 3.2            the search for a segment             cohsm__list_block, cohsm__block_find T59
     section 3.3, figure 5  six faces of a cube in one list      cohsm__face_of, cohsm__address       T70
     section 4              D, where the maps look from          cohsm_domain, cohsm__map_parameter   T73
     section 4.1            from a direction to its map          cohsm__domain_position               T64, T72
     section 4.2            lights at fixed positions            cohsm_light_kind, cohsm__address     T70, T73
     section 4.3, figure 7  lights outside the convex hull       cohsm__light_refused,                T67, T68
                                                                 cohsm__hull_between
     section 4.4            the domain in N even cells           cohsm__cell_location                 T64, T73
     section 4.4, figure 8  scan-line, zig-zag, Hilbert          cohsm__order_cells,                  T65
                                                                 cohsm__place_of_cell
     section 4.5, figure 9  filtering, Russian roulette          cohsm__pcf, cohsm__jitter            T69
     section 4.6, figure 10 several objects, D times T^-1        cohsm_visible_scene,                 T62, T66
                                                                 cohsm__load_tile
     section 4.6            receivers that have no maps          cohsm_visible_scene, entities of     T62
                                                                 cohsm_query
     section 5, visibility  lookup texture and lists             cohsm__lay_list, cohsm__search_tile  T59
     section 5, the rest    the estimator                        in lightsampling.h                   -
     section 6, quality     the bias                             cohsm_query                          T71
     section 6, figure 13   what N and M leave of the truth      cohsm_desc, cohsm_visible            T72,
                                                                                                 furnace
     section 7              adaptive sampling: fewer places      cohsm_places_choose                  T70
     table 1                compression rates                    cohsm_get_info                       T63
     table 2                queries a second                     cohsm_visible, cohsm_layout          -

   The last column names the rows of docs/conformance.md that test a line; a - says that there is none.
   docs/csm.md says where the code departs from the paper, and why.

   Configuration

     CSM_IMPLEMENTATION   in one source file: compiles the code
     COHSM_STATIC         beside it: a private copy for this file, all functions static
     COHSM_DEF            everywhere: your own linkage instead
     COHSM_NO_SIMD        with the implementation: portable code only (results are the same)
     COHSM_FILE           with the implementation: this file's name, if it is not "csm.h". The file includes
                          itself to compile the kernels for AVX2 and AVX-512, and does without these kernels
                          if __has_include does not find it

   In the repository, make join csm.h WITHOUT="build" writes this header without the precomputation, for
   programs that only open files and ask; WITHOUT="all" leaves out all that is optional, such as packed
   files, streams of objects and intrinsics (src/README.md).

   Memory, errors, threads, determinism

   All memory comes from the allocator of cohsm_system, called from the thread that called us. Maps and
   builders keep allocator, log and user of the system that they were made with: these must live as long.
   Every function that can fail returns a cohsm_result; if the result is not COHSM_OK, outputs are untouched
   and nothing leaks. The log says why a call failed, unless the maps, the builder or the desc that hold it
   are NULL. There are no globals: any number of threads may query the same maps; a builder or a stream of
   objects belongs to one thread at a time. Blocks built from the same input have the same bytes on every
   compiler, processor, byte order and thread count (not with x87 arithmetic, nor with clang's -ffast-math).

   Cost: docs/csm.md and build/bench csm_query.   History: CHANGELOG.md.   Licence: end of this file. */
#ifndef CSM_H
#define CSM_H

#define COHSM_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "csm.h needs C99 or C++11"
#endif
#if defined(COHSM_STATIC) && !defined(CSM_IMPLEMENTATION)
#error "COHSM_STATIC makes all functions private: CSM_IMPLEMENTATION belongs into the same file"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef COHSM_DEF
#ifdef COHSM_STATIC
#define COHSM_DEF static inline
#else
#define COHSM_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/csm/api_page_one.h ==== */

/* ---- page one: maps of a mesh, and points that ask them ---- */

#define COHSM_RESULTS(X)                                                                                    \
    X(COHSM_OK, "ok")                                                                                       \
    X(COHSM_ERR_ARGUMENT, "a pointer is NULL, or a count or stride is out of range")                        \
    X(COHSM_ERR_DESC, "a field of a desc is out of range")                                                  \
    X(COHSM_ERR_INPUT, "the data cannot be used")                                                           \
    X(COHSM_ERR_ALLOC, "the allocator returned no memory")                                                  \
    X(COHSM_ERR_MEMORY, "the caller's memory is too small or misaligned")                                   \
    X(COHSM_ERR_LIMIT, "a size overflows or passes a limit")                                                \
    X(COHSM_ERR_CANCELLED, "cancelled by the progress callback")                                            \
    X(COHSM_ERR_ORDER, "this call comes too early, too late or twice")                                      \
    X(COHSM_ERR_FORMAT, "not a file of this kind, or a damaged one")                                        \
    X(COHSM_ERR_VERSION, "a file of an unknown version")                                                    \
    X(COHSM_ERR_MISMATCH, "what was given does not belong together")

typedef enum cohsm_result {
#define COHSM__ENUM(name, text) name,
    COHSM_RESULTS(COHSM__ENUM)
#undef COHSM__ENUM
    COHSM_RESULT_COUNT
} cohsm_result;

typedef struct cohsm_maps cohsm_maps;       /* one object's shadow maps, compressed into one block of bytes */
struct cohsm_mesh;                  /* the object's triangles */
struct cohsm_query;                 /* points, and the light of each */
struct cohsm_instance;              /* an object of a scene: maps, and where the object stands */
struct cohsm_desc;                  /* which maps a build makes: see "settings of a build" below */
struct cohsm_stats;                 /* what a build counted: see there */

#ifndef COHSM_WITHOUT_BUILD
COHSM_DEF cohsm_result cohsm_build(const struct cohsm_desc *desc, const struct cohsm_mesh *mesh,
                                   cohsm_maps **out, struct cohsm_stats *stats);
/* Renders the shadow maps of a mesh from all directions or positions of the desc and compresses them.
   desc     NULL = all defaults: 128 x 128 directions, each map 128 x 128 pixels
   out      receives the maps, on COHSM_OK only; give them back by cohsm_free
   stats    may be NULL; receives what the build counted, on COHSM_OK only
   Errors   COHSM_ERR_ARGUMENT (NULL, a stride, a count of corners that is 0 or no multiple of 3, both kinds
            of indices), COHSM_ERR_DESC, COHSM_ERR_INPUT (an index beyond vertex_count, no usable triangle, a
            location), COHSM_ERR_LIMIT (2^31 corners, maps of 4 GiB), COHSM_ERR_ALLOC, COHSM_ERR_CANCELLED
   Cost     Time grows with maps x (triangles + pixels). The memory needed is the sum of these, for N maps of
            M pixels a side, of which a shard has n pixels (M^2 without shards): at most 100 bytes a triangle
            at first, then 40 (44 with a mask); 32 views of 4 M^2 bytes (Z1Z2) or 8 M^2, if M is at most 128
            64 views (with a parallel_for 128); 800,000 (with a parallel_for 1,500,000); 80 n; 4 N (20 N with
            locations); 16 bytes a segment of the last 65,536 maps; and twice the block. While defaults of
            order and orientation are tried, up to 34 MB and 20 M^2 come on top. For COHSM_LAYOUT_FAST the
            trays do, and while they are made what cohsm_open_as says */
#endif

COHSM_DEF cohsm_result cohsm_visible(const cohsm_maps *maps, const struct cohsm_query *query, float *visible,
                                     size_t *refused);
/* Writes for each point whether the object lets the point's light through. Points and lights are in the
   object's space.
   visible  receives query->count floats: 1 lit, 0 shadowed, between them with COHSM_FILTER_PCF, or
            COHSM_REFUSED. A point or light that is not finite, and a direction of length 0, give 1, since
            nothing is known about them
   refused  may be NULL; receives how many points were given COHSM_REFUSED
   Errors   COHSM_ERR_ARGUMENT (NULL, a stride), COHSM_ERR_DESC (light_kind, filter, bias),
            COHSM_ERR_MISMATCH (these maps cannot answer this kind of light). The log is that of the system
            that the maps were made with
   Cost     About one cache miss for each point; with PCF 2^(d + 2) of them, d being the dimensions of the
            domain. Any number of threads may ask the same maps */

COHSM_DEF cohsm_result cohsm_visible_scene(const struct cohsm_instance *instances, size_t instance_count,
                                           const struct cohsm_query *query, float *visible, size_t *refused);
/* Writes the same for a scene of several objects: for each point the product of what each object lets through
   (section 4.6). Points and lights are in world space. The object that a point lies on is asked first; the
   others follow in the order of the list while some light is left. The first object that refuses the light
   decides: the answer is COHSM_REFUSED then. Instance i draws the random numbers of COHSM_FILTER_ROULETTE as
   if it were asked alone with the seed query->seed + i * 0x9e3779b9.
   instances  may be NULL if instance_count is 0: every point is lit then
   Errors     those of cohsm_visible; COHSM_ERR_ARGUMENT also for instances without maps, COHSM_ERR_INPUT
              (a transform that shears, mirrors or scales unevenly), COHSM_ERR_LIMIT (2^32 - 1 instances or
              more). The log is that of the first maps of the scene; a scene without maps has none
   Cost       that of cohsm_visible for each instance whose bounding sphere the way to the light meets, and
              for any other instance some 25 instructions for 8 points (16 with AVX-512). Spheres are tested
              if the lights are directions or positions and there are four instances or more; but
              maps with self_only, and maps of so few directions that a cell is a radian wide (5 x 2, with PCF
              or ROULETTE 9 x 4), are asked by every direction */

COHSM_DEF void cohsm_free(cohsm_maps *maps);
/* Gives back the maps and their memory. NULL is allowed. */

COHSM_DEF const char *cohsm_result_text(cohsm_result result);
/* Returns a constant string that says what a result means; "unknown result" for a number that is none. */

/* ---- memory, threads, progress, log: the caller's ---- */

typedef struct cohsm_allocator {    /* all zero: malloc and free; else both functions */
    void *(*alloc_fn)(size_t bytes, void *user);    /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} cohsm_allocator;

typedef void (*cohsm_task)(void *context, size_t index);

typedef struct cohsm_system {       /* all zero: malloc and free, this thread alone, no progress, no log */
    cohsm_allocator allocator;      /* called from the thread that called us */
    void (*parallel_for)(void *user, size_t count, cohsm_task task, void *context);
    /* Must call task(context, i) once for each i < count, in any order and on any threads, and return when
       all are done. What is computed does not depend on the threads. */
    int (*progress)(void *user, float fraction);
    /* Called from the thread that called us, fraction 0..1 never falling within a call; not 0 cancels. */
    void (*log)(void *user, const char *message);
    /* Called at most once by a call that fails, from the thread that called us, before it returns: one line
       without a line end that names the function, the field or element, its value and its range. */
    void *user;                     /* given to parallel_for, progress and log */
} cohsm_system;

/* ---- structs of page one ---- */

#ifndef COHSM_WITHOUT_BUILD
typedef int (*cohsm_mask_fn)(void *user, uint32_t triangle, const float weights[3]);
/* A function of yours that says whether a triangle is there: not 0, or 0 in a hole of its alpha mask. The
   weights of the triangle's corners, which add up to 1, say at which point. parallel_for's threads call the
   function. */

typedef struct cohsm_mesh {
    const float    *positions;      /* x, y, z of each vertex */
    size_t          vertex_count;
    size_t          vertex_stride;  /* bytes from one vertex to the next, a multiple of 4, >= 12; 0 = 12 */
    const uint32_t *indices;        /* three to a triangle; NULL = indices16, or else 0, 1, 2, ... */
    size_t          index_count;    /* a multiple of 3 (ignored without indices: vertex_count is used) */
    const uint16_t *indices16;      /* in place of indices; not both */
    cohsm_mask_fn   mask_fn;        /* holes of an alpha mask, asked for at centres of pixels; NULL = none. A
                                       mesh with a mask is drawn without vectors, and of triangles with the
                                       same corners the first one's mask counts */
    void           *user;           /* given to mask_fn */
} cohsm_mesh;
#endif

typedef enum cohsm_light_kind {     /* what the lights of a query are */
    COHSM_LIGHT_DEFAULT,            /* = COHSM_LIGHT_DIRECTION */
    COHSM_LIGHT_DIRECTION = COHSM_LIGHT_DEFAULT,    /* a light is the direction to it, x, y, z of any length.
                                       The maps must be maps of directions, LATLONG or OCTAHEDRAL */
    COHSM_LIGHT_POSITION,           /* a light is a position x, y, z near by, outside the convex hull of every
                                       object (a semi-local light, section 4.3). The maps must be maps of
                                       directions */
    COHSM_LIGHT_PARAMETER,          /* a light is d parameters in 0..1 (floats; others are clamped), which the
                                       domain of the maps takes to a place or a direction. The domain may be
                                       any but LIST */
    COHSM_LIGHT_INDEX,              /* a light is the number of a map, a uint32_t. The domain may be any; a
                                       point with a number beyond the maps is lit */
    COHSM_LIGHT_COUNT
} cohsm_light_kind;

typedef enum cohsm_filter {         /* how many maps and pixels answer for a point */
    COHSM_FILTER_DEFAULT,           /* = COHSM_FILTER_NEAREST */
    COHSM_FILTER_NEAREST = COHSM_FILTER_DEFAULT,    /* the nearest map, and its nearest pixel: 0 or 1 */
    COHSM_FILTER_PCF,               /* percentage closer filtering: 4 pixels of each of the 2^d nearest maps,
                                       weighted by distance: 0..1 (section 4.5) */
    COHSM_FILTER_ROULETTE,          /* Russian roulette: one of the pixels of PCF at random, with its weight
                                       as its probability: 0 or 1, and in the mean what PCF gives */
    COHSM_FILTER_COUNT
} cohsm_filter;

#define COHSM_REFUSED (-1.0f)       /* the answer if a light stands inside an object's convex hull: maps of
                                       directions see an object from outside only. The hull is kept as a k-DOP
                                       (see "Conventions"), so that a light just outside the true hull may be
                                       refused too */

typedef struct cohsm_query {        /* points and lights; zero it, then set what you care about */
    size_t           count;         /* of receivers */
    const float     *positions;     /* x, y, z of each receiver: world space, or object space for
                                       cohsm_visible */
    size_t           position_stride;   /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const void      *lights;        /* one light for each receiver, of the type that light_kind says */
    size_t           light_stride;  /* bytes from one light to the next, a multiple of 4; 0 = packed: 12 for
                                       DIRECTION and POSITION, 4 d for PARAMETER, 4 for INDEX. The coords of
                                       lightsampling.h are parameters that lie 12 bytes apart */
    int              one_light;     /* not 0: lights holds one light, that of all receivers. Such queries are
                                       much faster with NEAREST, twice that if receivers are
                                       sorted along a curve, unless the light is a POSITION */
    cohsm_light_kind light_kind;
    cohsm_filter     filter;
    float            bias;          /* receivers count as nearer to the light by this many pixels of a map,
                                       lest surfaces shadow themselves; 0 = 1, negative = none */
    uint32_t         seed;          /* of COHSM_FILTER_ROULETTE: receiver i draws its numbers from seed, i
                                       and the instance */
    const uint32_t  *entities;      /* the instance that each receiver lies on, counted from 1, which is asked
                                       first; 0 or a number beyond the list = none. NULL = all none. Ignored
                                       by cohsm_visible */
} cohsm_query;

typedef struct cohsm_instance {     /* an object of a scene; several may share maps */
    const cohsm_maps *maps;
    float transform[16];            /* object to world: a rotation, one scale > 0, a translation; all zero =
                                       the identity */
} cohsm_instance;

typedef struct cohsm_sight {        /* what cohsm_see asks: a scene of objects about a list of lights */
    const cohsm_instance *instances;    /* as for cohsm_visible_scene; several threads ask them */
    size_t      instance_count;
    cohsm_query query;              /* of it light_kind, lights, light_stride, filter, bias and seed. Light
                                       number n is element n of query.lights; if lights is NULL and light_kind
                                       COHSM_LIGHT_INDEX, the light has map n */
} cohsm_sight;

COHSM_DEF void cohsm_see(void *sight, const float position[3], const float normal[3],
                         const uint32_t *numbers, size_t count, float *visible);
/* Writes how much of each of these lights one receiver sees, as cohsm_visible_scene does. The function is an
   rsm_visible_fn of rsm.h and an ism_visible_fn of ism.h: set it there, so that bounced light has shadows
   from these maps. Any number of threads may call it at once.
   sight    a cohsm_sight
   normal   not read
   numbers  numbers of lights
   visible  count floats in 0..1. 1 where COHSM_REFUSED is the answer, since nothing is known there; 0
            for all where cohsm_visible_scene fails, which the log of the maps is told
   Pointers must not be NULL, and sight->query.lights must have all lights whose numbers are given: neither is
   checked.
   Cost     that of cohsm_visible_scene for count points */

COHSM_DEF void cohsm_light_locations(const float *positions, size_t position_stride, const float *normals,
                                     size_t normal_stride, size_t count, float lift, float *locations);
/* Writes cohsm_domain.locations of maps for lights that lie on surfaces, such as the texels of a reflective
   shadow map: with COHSM_DOMAIN_LIST light n has map n then.
   positions   x, y, z of each light, position_stride bytes apart; 0 = 12
   normals     unit, of the surfaces; normal_stride bytes apart, 0 = 12
   lift        how far maps stand above the surfaces, lest these hide all; a hundredth of a unit or so
   locations   receives 4 floats for each light: x, y, z, 1
   Pointers must not be NULL and strides be multiples of 4: neither is checked. */

/* ==== src/csm/api_desc.h ==== */

/* ---- settings of a build ---- */

typedef enum cohsm_domain_kind {    /* where the maps look from: a mapping D of d parameters in 0..1 to
                                       directions towards the light (w = 0), or to positions on it (w = 1) */
    COHSM_DOMAIN_DEFAULT,           /* = COHSM_DOMAIN_LATLONG */
    COHSM_DOMAIN_LATLONG,           /* d = 2, w = 0: s = 0.5 + atan2(z, x) / 2 pi, t = acos(y) / pi; row 0 is
                                       +Y */
    COHSM_DOMAIN_OCTAHEDRAL,        /* d = 2, w = 0: the sphere on a square by the equal-area octahedral map
                                       (Clarberg 2008); side[0] and side[1] must be equal */
    COHSM_DOMAIN_LINE,              /* d = 1, w = 1: origin + s u */
    COHSM_DOMAIN_RECTANGLE,         /* d = 2, w = 1: origin + s u + t v */
    COHSM_DOMAIN_DISC,              /* d = 2, w = 1: the disc about origin with the half axes u and v; the
                                       square s, t goes to the disc by Shirley and Chiu's concentric map */
    COHSM_DOMAIN_SPHERE,            /* d = 2, w = 1: the surface of the sphere of radius |u| about origin;
                                       s turns about +Y, t runs with equal areas from +Y to -Y */
    COHSM_DOMAIN_VOLUME,            /* d = 3, w = 1: origin + s u + t v + r w */
    COHSM_DOMAIN_TABLE,             /* d = 1..3: a mapping of your own, given by its values at the cells'
                                       centres in `locations` */
    COHSM_DOMAIN_LIST,              /* d = 0: any set of locations, such as virtual lights, which queries name
                                       by index; PCF takes no mean over locations */
    COHSM_DOMAIN_COUNT
} cohsm_domain_kind;

typedef enum cohsm_layers {         /* how far behind the first hit a stored depth may lie, which makes blocks
                                       smaller. z1, z2, z3 are the depths at which the ray of a pixel meets
                                       the object first, second and third */
    COHSM_LAYERS_DEFAULT,           /* = COHSM_LAYERS_Z1Z2 */
    COHSM_LAYERS_Z1Z2,              /* up to z2, or as open_thickness says if there is no z2: right for every
                                       receiver */
    COHSM_LAYERS_Z1Z3_SPHERE,       /* up to z3, or to where the ray leaves the bounding sphere: for closed
                                       surfaces */
    COHSM_LAYERS_Z1Z3_FAR,          /* up to z3, or without an end: for closed surfaces that have nothing else
                                       behind them */
    COHSM_LAYERS_COUNT
} cohsm_layers;

typedef enum cohsm_order {          /* the sequence in which maps are stored; the more alike neighbours look,
                                       the smaller the block */
    COHSM_ORDER_DEFAULT,            /* LATLONG to VOLUME: cohsm_build tries HILBERT and ZIGZAG_THETA on small
                                       versions of the build, which takes a seventh of its time. HILBERT for
                                       TABLE and a cohsm_builder; LINE and LIST are always SCANLINE */
    COHSM_ORDER_SCANLINE,           /* lines along the first dimension, one after another */
    COHSM_ORDER_ZIGZAG,             /* the same lines, every other one backwards */
    COHSM_ORDER_ZIGZAG_THETA,       /* zig-zag by lines along the second dimension */
    COHSM_ORDER_HILBERT,            /* Hilbert's curve, for any sides; no step is diagonal if the sides are
                                       powers of two */
    COHSM_ORDER_COUNT
} cohsm_order;

typedef enum cohsm_orientation {    /* which way is up in the image of a direction's map */
    COHSM_ORIENTATION_DEFAULT,      /* cohsm_build tries POLAR and TWO_POLES with each order. POLAR for TABLE,
                                       LIST and a cohsm_builder */
    COHSM_ORIENTATION_POLAR,        /* up is towards +Y; right is towards larger s of LATLONG */
    COHSM_ORIENTATION_MINIMAL,      /* axes follow from those at +Y by the shortest rotation to the direction;
                                       they turn fast near -Y */
    COHSM_ORIENTATION_TWO_POLES,    /* the same from the nearer of +Y and -Y; axes jump at the equator */
    COHSM_ORIENTATION_COUNT
} cohsm_orientation;

typedef enum cohsm_layout {         /* how maps lie in memory; answers are the same */
    COHSM_LAYOUT_DEFAULT,           /* = COHSM_LAYOUT_COMPACT */
    COHSM_LAYOUT_COMPACT = COHSM_LAYOUT_DEFAULT,    /* the block alone, which is the file too */
    COHSM_LAYOUT_FAST,              /* the block and, beside it, trays, in which a query finds a depth by
                                       reading 2 bytes and one cache line, without decoding. Trays take about
                                       1.4 times the bytes of the block (cohsm_info.fast_bytes) */
    COHSM_LAYOUT_BUDGET,            /* FAST if block and trays take layout_bytes or less, else COMPACT */
    COHSM_LAYOUT_COUNT
} cohsm_layout;

#ifndef COHSM_WITHOUT_BUILD
typedef struct cohsm_domain {
    cohsm_domain_kind kind;
    uint32_t side[3];               /* cells along each dimension, 1..4096 (TABLE: 1..2^24). Their product N
                                       is the number of maps, at most 2^24. 0 = 128, or 32 for VOLUME, or 1
                                       for TABLE and for dimensions that the kind does not have */
    float origin[3], u[3], v[3], w[3]; /* the shape of LINE to VOLUME, in the mesh's space and units */
    const float *locations;         /* TABLE, LIST: x, y, z, w of each cell, the first dimension fastest; w is
                                       0 for all (x, y, z of any length but 0) or 1 for all. The library
                                       copies them */
    size_t location_count;          /* TABLE: the product of side; LIST: N, 1..2^24, and side is ignored */
} cohsm_domain;

typedef struct cohsm_desc {         /* zero it, then set what you care about */
    cohsm_system system;
    cohsm_domain domain;
    uint32_t     map_side;          /* M, the pixels a side of a map, 4..1024; 0 = 128 */
    cohsm_layers layers;
    cohsm_order  order;
    cohsm_orientation orientation;  /* ignored for maps of positions */
    uint32_t     depth_bits;        /* stored depths lie on a grid of so many bits, 4..8; 0 = 8. If no grid
                                       value separates the layers, a depth is kept in 16 bits: fewer bits
                                       make more segments, but never a wrong answer */
    float        open_thickness;    /* map pixels, >= 0; 0 = 8. How far behind a surface without a second hit
                                       (a leaf, an open border) the stored depth may lie, which leaks light
                                       onto receivers right behind that surface; map_side or more: to the far
                                       side of the bounding sphere, as in the paper */
    int          self_only;         /* not 0: pixels that nothing hits may store anything. The block is
                                       smaller, and answers only for points on the object's own surface */
    float        center[3], radius; /* a sphere that holds the mesh, in the mesh's units, radius 1e-18..1e18;
                                       0 = the sphere is fitted to the mesh, center too (a cohsm_builder,
                                       which has no mesh, needs a sphere) */
    uint32_t     pixel_begin, pixel_end;   /* a shard, for cohsm_merge: only the pixels begin..end - 1 of the
                                       map_side^2 of every map are built; 0, 0 = all */
    cohsm_layout layout;            /* how the finished maps lie in memory */
    size_t       layout_bytes;      /* of COHSM_LAYOUT_BUDGET: the most that block and trays may take */
} cohsm_desc;

typedef struct cohsm_stats {        /* what a build counted */
    uint64_t segments;              /* segments of all pixels together */
    uint64_t exact_depths;          /* segments of one view whose depth is kept in 16 bits, since no value of
                                       the grid separates the layers */
    uint64_t empty_intervals;       /* pixels of views whose next layer lies at z1 itself: z1 is stored, and
                                       only a query's bias keeps the surface from shadowing itself */
    uint64_t open_entries;          /* pixels of views with one hit only: they see an open border or a
                                       sheet */
    uint32_t triangles;             /* triangles that were used */
    uint32_t skipped_triangles;     /* triangles left out because a vertex was not finite or two corners were
                                       equal */
    uint32_t duplicate_triangles;   /* triangles left out because an earlier one had the same three corners,
                                       in any order */
    cohsm_order order;              /* the sequence in which the maps are stored: desc.order, or the one that
                                       COHSM_ORDER_DEFAULT and the kind of the domain led to */
    size_t   peak_bytes;            /* the most bytes that the allocator had given out at once */
} cohsm_stats;

COHSM_DEF cohsm_result cohsm_budget(const cohsm_desc *desc, const cohsm_mesh *mesh, size_t bytes,
                                    uint32_t *side, uint32_t *map_side);
/* Finds the side of a LATLONG or OCTAHEDRAL domain and the side M of a map with the least expected error
   among those whose block is expected to stay below so many bytes. The size of a block is measured on builds
   of side 16 and 32 and continued by their growth, with a tenth in reserve. The expected error is
   0.0055 (128 / side) + 0.0185 sqrt(128 / M), the share of rays that snapping to directions and to pixels
   gets wrong on the bunny (docs/csm.md).
   desc     NULL = all defaults; its domain.side, map_side, pixels of a shard and layout are ignored
   side, map_side   receive what to write into domain.side[0], domain.side[1] and map_side, on COHSM_OK only
   Errors   those of cohsm_build; COHSM_ERR_DESC also for another domain, COHSM_ERR_LIMIT also if not even
            side 8 with M = 16 fits
   Cost     about that of a build of side 40 */
#endif

/* ==== src/csm/api_maps.h ==== */

/* ---- facts of maps ---- */

typedef struct cohsm_info {         /* what has no comment is as in cohsm_desc, its defaults filled in */
    cohsm_domain_kind domain;
    cohsm_layers layers;
    cohsm_order  order;
    cohsm_orientation orientation;
    uint32_t side[3];
    uint32_t map_count;             /* N */
    uint32_t view_count;            /* N, or 6 N for positions, whose maps have the six faces of a cube */
    uint32_t map_side;              /* M */
    uint32_t depth_bits;
    uint32_t dimensions;            /* d */
    int      positional;            /* not 0: maps of positions, w = 1 */
    int      self_only;
    uint32_t pixel_begin, pixel_end;
    float    center[3], radius;
    float    depth_far;             /* positions: the distance that a depth of 1 stands for */
    uint64_t segment_count;         /* of all pixels together */
    size_t   bytes;                 /* of the block */
    cohsm_layout layout;            /* COHSM_LAYOUT_COMPACT or COHSM_LAYOUT_FAST */
    size_t   fast_bytes;            /* of the trays beside the block; 0 where the layout is compact */
    size_t   memory_bytes;          /* that the maps take of the allocator: block, trays and tables; without
                                       the block if they read a file in place (cohsm_open_file) */
    double   ratio;                 /* the paper's compression ratio: view_count * pixels * 2 bytes of plain
                                       16-bit maps / bytes; pixels are M * M, or those of a shard */
} cohsm_info;

COHSM_DEF void cohsm_get_info(const cohsm_maps *maps, cohsm_info *out);
/* Writes what the maps were built with and how large they are. Does nothing if a pointer is NULL. */

COHSM_DEF cohsm_result cohsm_location(const cohsm_maps *maps, uint32_t map, float out[4]);
/* Writes where a map looks from, x, y, z, w: the value of D at the centre of the map's cell.
   map      0..map_count - 1, counted with the first dimension fastest, not in the order of storage
   out      w = 0: x, y, z is the unit direction towards the light; w = 1: a position
   Errors   COHSM_ERR_ARGUMENT (NULL, or map is not below map_count) */

COHSM_DEF cohsm_result cohsm_depths(const cohsm_maps *maps, uint32_t view, uint16_t *out);
/* Decompresses one view, for tests, and for renderers that want one plain shadow map. Writes the stored
   depths of its pixels, M * M or those of a shard, row 0 at y = 0: z * 65533, 65534 for the sphere's far
   side, 65535 for infinity.
   view     the map's number as cohsm_location counts; for maps of positions face * N + the map's number
   Errors   COHSM_ERR_ARGUMENT (NULL, or a view that is too large)
   Cost     one search for each pixel */

/* ---- files ---- */

COHSM_DEF const void *cohsm_data(const cohsm_maps *maps, size_t *bytes);
/* Returns the block, which is the plain file as it stands and is what a GPU gets, and writes its bytes. The
   block consists of 32-bit words without pointers (docs/csm-format.md) in the byte order of the host; the
   file is little-endian, so write it by cohsm_write on big-endian hosts. The block lives as long as the maps;
   of maps that read a file in place it is that file.
   maps     NULL gives NULL
   bytes    may be NULL */

COHSM_DEF const void *cohsm_fast_data(const cohsm_maps *maps, size_t *bytes);
/* Returns what a GPU gets in place of the block if it is to answer faster, and writes its bytes: the block's
   header and directions, then the trays of COHSM_LAYOUT_FAST (docs/gpu-layouts.md), in the byte order of the
   host. It is no file, and lives as long as the maps. Returns NULL and 0 bytes for maps in the compact layout
   and for trays of 4 GB or more.
   maps     NULL gives NULL
   bytes    may be NULL */

COHSM_DEF cohsm_result cohsm_write(const cohsm_maps *maps, void *memory, size_t memory_bytes);
/* Writes the plain file, cohsm_info.bytes bytes that are the same on a host of any byte order.
   Errors   COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_MEMORY (memory_bytes is below cohsm_info.bytes) */

COHSM_DEF cohsm_result cohsm_open(const void *data, size_t bytes, const cohsm_system *system,
                                  cohsm_maps **out);
/* Makes maps from a plain or packed file in memory; cohsm_free takes the maps back. The file is copied and
   need not outlive the call. It may come from anywhere: version, sizes, checksum and every list are checked
   before anything is used.
   system   NULL: malloc and free, no progress, no log
   Errors   COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_DESC (allocator), COHSM_ERR_FORMAT, COHSM_ERR_VERSION,
            COHSM_ERR_ALLOC, COHSM_ERR_CANCELLED, COHSM_ERR_MISMATCH (a packed file, in a header that was
            joined without pack)
   Cost     at most 64 bytes of memory for each byte of the file, and 256 KB; for the time see cohsm_pack */

#ifndef COHSM_WITHOUT_FAST
COHSM_DEF cohsm_result cohsm_open_as(const void *data, size_t bytes, cohsm_layout layout, size_t layout_bytes,
                                     const cohsm_system *system, cohsm_maps **out);
/* Does what cohsm_open does, and lays the maps out in memory for size or for speed.
   layout        COHSM_LAYOUT_FAST makes trays from the block; COHSM_LAYOUT_BUDGET only if they fit
   layout_bytes  of COHSM_LAYOUT_BUDGET: the most bytes that block and trays may take together
   Errors        those of cohsm_open; COHSM_ERR_ARGUMENT also for layout; COHSM_ERR_LIMIT (256 GiB of trays)
   Cost          that of cohsm_open, and for trays 0.2 to 0.3 microseconds and 2 bytes to 1 KB of memory for
                 each pixel and 256 views; while they are made 0.5 MB more, or eight times that with a
                 parallel_for. The bytes of trays do not follow from those of the file: if files are not
                 trusted, COHSM_LAYOUT_BUDGET keeps block and trays within layout_bytes */
#endif

/* ==== src/csm/api_pack.h ==== */

COHSM_DEF cohsm_result cohsm_pack(const cohsm_maps *maps, const cohsm_system *system, void **data,
                                  size_t *bytes);
/* Makes a packed file, from which cohsm_open makes the same block again. The lists of a pixel are
   entropy-coded with those of its neighbours as context, which takes about half of the plain size, and far
   less for simple objects.
   system   NULL: malloc and free, no progress, no log
   data     receives memory from the system's allocator, on COHSM_OK only: give it back to that allocator
   bytes    receives the size of the file, on COHSM_OK only
   Errors   COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_DESC (allocator), COHSM_ERR_ALLOC, COHSM_ERR_LIMIT,
            COHSM_ERR_CANCELLED
   Cost     About 1 microsecond a segment, half of it to check that the file decodes to the same block;
            cohsm_open needs half a microsecond a segment. The memory needed is twice the block and the packed
            file */

/* ==== src/csm/api_stream.h ==== */

/* ---- files in place, and more objects than memory holds ---- */

typedef struct cohsm_open_desc {    /* how cohsm_open_file opens a file */
    cohsm_system system;
    cohsm_layout layout;            /* as for cohsm_open_as */
    size_t       layout_bytes;      /* of COHSM_LAYOUT_BUDGET: the most bytes that block and trays may take
                                       together, the block counting where it is read in place, too */
    size_t       budget_bytes;      /* the most bytes of memory that the file may cost; 0 = any number. What
                                       counts are the maps, their trays, and what a packed file takes while
                                       it is decoded; a file that is read in place does not. All but the
                                       trays is known by the header, and compared before any memory is asked
                                       for. What works on trays while they are made comes on top, 0.5 MB, or
                                       eight times that with a parallel_for */
    int          in_place;          /* not 0: the maps read the file where it lies, such as a file that the
                                       system has mapped into memory, and keep no copy of it. The file must
                                       begin at a multiple of 64 bytes, and stay as it is until cohsm_free.
                                       Packed files, and all files on big-endian hosts, are decoded into
                                       memory all the same */
} cohsm_open_desc;

COHSM_DEF cohsm_result cohsm_open_file(const cohsm_open_desc *desc, const void *data, size_t bytes,
                                       cohsm_maps **out);
/* Does what cohsm_open does, within a budget or without a copy. Everything is checked here, too, so that the
   whole file is read once; later, a query reads the few lines that it asks for.
   desc     NULL = all defaults: that is cohsm_open
   Errors   those of cohsm_open_as, but COHSM_ERR_DESC for the layout; COHSM_ERR_LIMIT also if the file costs
            more than budget_bytes (the log says how much), or with the trays of COHSM_LAYOUT_FAST would;
            COHSM_ERR_MEMORY (in_place, and data is not at a multiple of 64 bytes) */

COHSM_DEF cohsm_result cohsm_file_info(const void *data, size_t bytes, const cohsm_system *system,
                                       cohsm_info *out);
/* Writes what a plain or packed file holds, by its header alone, which is checked; the rest is not read.
   out      receives what cohsm_get_info would write for the maps that cohsm_open makes of the file
   system   NULL: no log. Nothing else of it is used
   Errors   COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_FORMAT, COHSM_ERR_VERSION, COHSM_ERR_MISMATCH (a packed file,
            in a header that was joined without pack) */

typedef struct cohsm_stream cohsm_stream;   /* many objects, of which as many as fit are in memory, in
                                               COHSM_LAYOUT_COMPACT */

typedef struct cohsm_stream_desc {
    cohsm_system system;            /* its allocator and log: parallel_for and progress are not called */
    uint32_t     object_count;      /* 1..2^24; each has a file */
    size_t       budget_bytes;      /* above 0: the most bytes that the objects in memory may take together:
                                       what the maps of each take (cohsm_info.memory_bytes), its file's bytes
                                       if it is read in place, and while a packed file is decoded what that
                                       takes. Beside them the stream takes 0.5 KB for each object */
    int          in_place;          /* as in cohsm_open_desc */
    int (*load_fn)(void *user, uint32_t object, const void **data, size_t *bytes);
    /* Writes where the file of an object is, read or mapped into memory, and its bytes; the same file each
       time. Returns 0; or another number if there is none, when unload_fn is not called and the call that
       wants the object ends with COHSM_ERR_CANCELLED. Neither function may call this stream's. */
    void (*unload_fn)(void *user, uint32_t object, const void *data, size_t bytes);
    /* Takes back what load_fn gave: as soon as the file has been copied or decoded or was refused, or, if it
       is read in place, when the object leaves memory. NULL = there is nothing to do. */
    void        *user;              /* given to load_fn and unload_fn */
} cohsm_stream_desc;

COHSM_DEF cohsm_result cohsm_stream_create(const cohsm_stream_desc *desc, cohsm_stream **out);
/* Makes a stream, which cohsm_stream_free takes back. Nothing is loaded yet.
   Errors   COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_DESC, COHSM_ERR_ALLOC */

COHSM_DEF cohsm_result cohsm_stream_use(cohsm_stream *stream, uint32_t object, const cohsm_maps **out);
/* Gives the maps of an object and holds it: the maps stay in memory until cohsm_stream_end was called as
   often as this function. If they are not there yet, the file is loaded and opened; as long as the budget has
   no room for it, objects that nobody holds leave, first the one whose last hold ended first. A stream
   belongs to one thread at a time; the maps may be asked by any number of threads.
   out      receives the maps, on COHSM_OK only
   Errors   COHSM_ERR_ARGUMENT (NULL, object), COHSM_ERR_CANCELLED (load_fn), COHSM_ERR_LIMIT (beside the
            objects that are held the budget has no room), those of cohsm_open_file, COHSM_ERR_INPUT (the
            object has another file than before). The log says which object */

COHSM_DEF void cohsm_stream_end(cohsm_stream *stream, uint32_t object);
/* Ends one hold of cohsm_stream_use. The maps stay in memory until others need the room, which may be in
   any later call: do not ask them any more. Does nothing for NULL, and for an object that is not held. */

typedef struct cohsm_stream_instance {  /* an object of a scene; several may name the same object */
    uint32_t object;                /* 0..object_count - 1 */
    float    transform[16];         /* as in cohsm_instance */
} cohsm_stream_instance;

COHSM_DEF cohsm_result cohsm_stream_visible_scene(cohsm_stream *stream,
                                                  const cohsm_stream_instance *instances,
                                                  size_t instance_count, const cohsm_query *query,
                                                  float *visible, size_t *refused);
/* Writes what cohsm_visible_scene writes, to the last bit, for a scene whose objects need not fit into memory
   together: one after the other is held and asked by all points. An object that was never loaded is loaded
   for its header. After that it is loaded only if the way of a point that still sees some light meets the
   object's sphere (or for any such point, where lights are parameters or indices).
   Errors   those of cohsm_visible_scene and cohsm_stream_use, when `visible` is untouched; COHSM_ERR_INPUT
            also if an instance names an object that the stream does not have. The log is that of the stream
   Cost     that of cohsm_visible_scene, and of loading; 4 bytes of memory for each point. A scene whose
            points meet more objects than fit, in the same order each time, loads all of them each time: order
            instances from near to far, or ask for the points of one region at a time */

typedef struct cohsm_stream_stats {
    uint32_t objects, held;         /* in memory; of them those that are held */
    size_t   bytes, peak_bytes;     /* what they take now, and took at most, by the rule of budget_bytes */
    uint64_t hits, loads, evictions;    /* holds that found the object in memory; that did not; objects that
                                           left for others */
} cohsm_stream_stats;

COHSM_DEF void cohsm_stream_get_stats(const cohsm_stream *stream, cohsm_stream_stats *out);
/* Does nothing if a pointer is NULL. */

COHSM_DEF void cohsm_stream_free(cohsm_stream *stream);
/* Gives back a stream and all its objects, held or not: their maps end with it. NULL is allowed. */

/* ==== src/csm/api_places.h ==== */

/* ---- fewer maps for the same answers ---- */

typedef struct cohsm_places_desc {
    cohsm_system       system;          /* parallel_for is not called */
    const cohsm_maps  *candidates;      /* maps of more places than you want to keep, N <= 16,384, such as
                                           small ones (map_side 32) of a LIST or TABLE: by their answers
                                           places are compared */
    const float       *receivers;       /* x, y, z of points as those that will ask, some thousands, in the
                                           space of the maps */
    size_t             receiver_count;  /* 1..2^28 */
    size_t             receiver_stride; /* bytes, a multiple of 4, >= 12; 0 = 12 */
    uint32_t           place_count;     /* K, how many of the candidates to choose, 1..N */
    float              bias;            /* as in cohsm_query */
} cohsm_places_desc;

COHSM_DEF cohsm_result cohsm_places_choose(const cohsm_places_desc *desc, uint32_t *places, uint32_t *instead,
                                           double *error);
/* Chooses those candidates that answer best for all others: adaptive sampling of a domain (section 7), by
   measured error. The error is the share of pairs of candidate and receiver whose answer changes if the
   candidate's map is replaced by that of the place which stands for it. Places are taken one by one, each
   where it lowers the error most, then exchanged as long as that lowers the error.
   places    receives place_count numbers of candidates, rising
   instead   receives for each of the N candidates the number within `places` of the one that stands for it,
             by which lights of the candidates ask maps of the places (COHSM_LIGHT_INDEX)
   error     may be NULL; receives the error, 0..1
   Errors    COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_DESC, COHSM_ERR_ALLOC, COHSM_ERR_CANCELLED
   Cost      N receiver_count queries, then N^2 (receiver_count / 32 + place_count) steps, and at most 16 N^2
             place_count for the exchanges; 4 N^2 + N receiver_count / 8 + 4 receiver_count bytes of memory */

/* ==== src/csm/api_builder.h ==== */

/* ---- layers from your own renderer ---- */

typedef struct cohsm_builder cohsm_builder; /* makes maps of layers that you render, one view at a time */

typedef struct cohsm_view {         /* the camera of one map, or of one face of a map of a position */
    uint32_t index;                 /* 0..view count - 1, the view's place in the sequence */
    uint32_t cell;                  /* the map's number, 0..N - 1, as cohsm_location counts */
    float matrix[16];               /* column-major. Orthographic: takes a point of object space to x, y in
                                       0..M (pixels, y up) and z, the linear depth in 0..1. Perspective: takes
                                       it to (x w, y w, 0, w), with x, y in pixels; its linear depth is
                                       w * depth_scale */
    float depth_scale;              /* of perspective views; 0 for orthographic ones */
    float location[4];              /* x, y, z, w of the map, as cohsm_location writes them */
    uint32_t face;                  /* 0..5: +X -X +Y -Y +Z -Z; 0 for orthographic views */
} cohsm_view;

COHSM_DEF cohsm_result cohsm_builder_create(const cohsm_desc *desc, cohsm_builder **out);
/* Makes a builder, which cohsm_builder_free takes back. Since a builder knows no mesh, cohsm_visible refuses
   semi-local lights inside a k-DOP of the bounding sphere, in place of those inside the object's hull.
   desc     needs center and a radius of 1e-18..1e18; its system serves all calls of the builder
   Errors   COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_DESC, COHSM_ERR_INPUT (a location), COHSM_ERR_LIMIT,
            COHSM_ERR_ALLOC
   Cost     A builder never holds all maps: its memory is that of cohsm_build without the triangles */

COHSM_DEF uint32_t cohsm_builder_view_count(const cohsm_builder *builder);
/* Returns how many views must be rendered: N for maps of directions, 6 N for maps of positions, 0 for
   NULL. */

COHSM_DEF cohsm_result cohsm_builder_view(const cohsm_builder *builder, uint32_t index, cohsm_view *out);
/* Writes the camera of a view.
   index    0..cohsm_builder_view_count - 1
   Errors   COHSM_ERR_ARGUMENT (NULL, or an index that is too large) */

COHSM_DEF cohsm_result cohsm_builder_add(cohsm_builder *builder, uint32_t index, const float *z1,
                                         const float *z2, const float *z3);
/* Takes the layers of a view and compresses them.
   index        0 for the first call, then one more with each call
   z1, z2, z3   M * M depths in 0..1 each (the view's linear depth; row 0 is y = 0), or above 1 if there is no
                such hit, with z1 <= z2 <= z3; z3 may be NULL with COHSM_LAYERS_Z1Z2
   Errors       COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_ORDER (another index), COHSM_ERR_INPUT (NaN, or layers
                out of order; the view may be given again), COHSM_ERR_ALLOC (the builder can then only be
                freed) */

typedef struct cohsm_segment {      /* a run of views for which one depth serves a pixel (equation 1) */
    uint32_t first;                 /* the view that it begins with; it ends before the pixel's next one */
    uint32_t pixel;                 /* of the map, y * M + x */
    uint32_t value;                 /* lo | hi << 8, lo <= hi < 2^depth_bits: each of the grid values lo..hi
                                       separates the layers of all its views, and the builder takes one; or
                                       a 16-bit depth | 1 << 16, which is stored exactly. Grid value i stands
                                       for the 16-bit depth floor(i 65535 / (2^depth_bits - 1)), the greatest
                                       for infinity. 16-bit depths are those that cohsm_depths writes */
} cohsm_segment;

COHSM_DEF cohsm_result cohsm_builder_import(cohsm_builder *builder, const cohsm_segment *segments,
                                            size_t count);
/* Takes the segments of all views at once, in place of their layers: from whoever has found them, such as the
   GPU (glbk_csm_builder_end). Nothing is compressed here; time goes by segments, not by views times pixels.
   cohsm_builder_finish comes next; its stats have no empty_intervals and no open_entries then.
   segments   count of them. Those of a pixel come in the order of their views, and those of views below a
              multiple of 65,536 before those from there on. Each pixel has one that begins with view 0, and
              with each multiple of 65,536. Pixels outside the range of a shard are left out
   Errors     COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_ORDER (views were added, or this was called before),
              COHSM_ERR_INPUT (a segment out of order or of range, or missing), COHSM_ERR_ALLOC. After the
              last two the builder can only be freed */

COHSM_DEF cohsm_result cohsm_builder_finish(cohsm_builder *builder, cohsm_maps **out, cohsm_stats *stats);
/* Makes the maps after the last view. The builder can then only be freed.
   out      receives the maps, on COHSM_OK only; cohsm_free takes them back
   stats    may be NULL
   Errors   COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_ORDER (a view is missing), COHSM_ERR_LIMIT,
            COHSM_ERR_ALLOC */

COHSM_DEF void cohsm_builder_free(cohsm_builder *builder);
/* Gives back a builder and its memory. NULL is allowed. */

/* ---- large builds in pieces ---- */

COHSM_DEF cohsm_result cohsm_merge(const cohsm_maps *const *shards, size_t count, const cohsm_system *system,
                                   cohsm_maps **out);
/* Makes the maps of a whole build from its shards, which stay as they are. The bytes are those of the build
   in one piece; the layout in memory is that of the first shard, COMPACT or FAST.
   shards   count of them, of one desc (pixel_begin, pixel_end), whose ranges of pixels follow each other from
            0 to M * M
   system   NULL: malloc and free, no progress, no log
   Errors   COHSM_ERR_ARGUMENT (NULL, a count of 0), COHSM_ERR_DESC (allocator), COHSM_ERR_MISMATCH (shards of
            different builds, or in another order), COHSM_ERR_LIMIT, COHSM_ERR_ALLOC, COHSM_ERR_CANCELLED */

/* ---- checking a build ---- */

typedef struct cohsm_report {       /* what cohsm_verify found */
    uint64_t entries;               /* pixels x views that were compared */
    uint64_t wrong;                 /* stored depths that do not separate their layers; 0 for every block that
                                       cohsm_build made of this mesh */
    uint64_t empty;                 /* pixels of views whose next layer lies at z1 itself, as in
                                       cohsm_stats.empty_intervals; they are right if they store z1 */
    uint32_t first_view, first_pixel;   /* of the first wrong entry, if there is one; a view counts in
                                       sequence, as cohsm_view.index does */
} cohsm_report;

COHSM_DEF cohsm_result cohsm_verify(const cohsm_maps *maps, const cohsm_system *system,
                                    const cohsm_mesh *mesh, cohsm_report *out);
/* Renders every view of the mesh again and compares every stored depth with the layers that the depth must
   separate (equation 1). COHSM_OK says that all were compared; out->wrong says how many were wrong.
   mesh     the mesh that the maps were built from
   system   NULL: malloc and free, this thread alone, no progress, no log
   Errors   those of cohsm_build; COHSM_ERR_MISMATCH (the mesh reaches out of the sphere of the maps)
   Cost     about that of cohsm_build */

/* ==== src/csm/api_end.h ==== */

#ifdef __cplusplus
}
#endif

#endif /* CSM_H */

/* ==== src/csm/begin.h ==== */

/* ==== implementation ==================================================================================== */

#if defined(CSM_IMPLEMENTATION) && !defined(CSM_IMPLEMENTED)

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The name of this file, by which it includes itself (see kernels_begin.h). Define COHSM_FILE if you renamed
   it. */
#ifndef COHSM_FILE
#define COHSM_FILE "csm.h"
#endif
#define COHSM__FILE COHSM_FILE

#ifdef COHSM_NO_SIMD
#define COHSM__NO_SIMD
#define COHSM__COMPILER_VECTORS
#endif

/* ==== src/shared/fp_begin.h ==== */

/* unit fp_begin: the arithmetic that the bytes depend on, from here to unit fp_end */

/* Forbids fused multiply-adds that the source does not ask for: gcc fuses across statements in its gnu modes
   and on s390x, clang within expressions. For gcc, the pragmas take a user's -ffast-math back. In clang,
   -ffast-math and -ffp-contract=fast win over the pragma: results then stay within tolerance, but are not
   equal to the bit. */
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#define COHSM__FINITE_MATH 1
#else
#define COHSM__FINITE_MATH 0
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

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
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

/* Returns 1 if so many bytes may lie between elements of floats that are `standard` bytes large: 0, which
   stands for `standard`, or a multiple of 4 with which elements do not overlap. */
static inline int cohsm__stride_valid(size_t stride, size_t standard)
{
    return stride == 0 || (stride >= standard && stride % 4 == 0);
}

/* Returns 1 if the functions of a public allocator are both there or both NULL. */
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

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
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

/* ==== src/shared/v3.h ==== */

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

static inline cohsm__v3 cohsm__v3_scale(cohsm__v3 a, float s)
{
    return cohsm__v3_make(a.x * s, a.y * s, a.z * s);
}

/* Returns a + b s. */
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

/* Returns a with length 1. The largest component scales the others first, so that neither tiny nor huge
   vectors leave the range of floats. The zero vector stays zero. */
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

/* Returns 1 if x is finite, by its exponent bits: under -ffast-math compilers may take isfinite() for always
   true. */
static inline int cohsm__finite(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7f800000u) != 0x7f800000u;
}

static inline int cohsm__v3_finite(cohsm__v3 a)
{
    return cohsm__finite(a.x) && cohsm__finite(a.y) && cohsm__finite(a.z);
}

/* ==== src/shared/m4.h ==== */

/* unit m4, needs v3: column-major 4 x 4 matrices, float[16], affine */

static inline cohsm__v3 cohsm__m4_point(const float *m, cohsm__v3 p)
{
    return cohsm__v3_make(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12],
                     m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                     m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]);
}

static inline cohsm__v3 cohsm__m4_direction(const float *m, cohsm__v3 d)
{
    return cohsm__v3_make(m[0] * d.x + m[4] * d.y + m[8] * d.z, m[1] * d.x + m[5] * d.y + m[9] * d.z,
                     m[2] * d.x + m[6] * d.y + m[10] * d.z);
}

/* Returns m, or the identity if all sixteen numbers are 0: so a struct that was zeroed stands where it is. */
static inline const float *cohsm__m4_or_identity(const float *m)
{
    static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    int i;
    for (i = 0; i < 16; i++)
        if (m[i] != 0.0f) return m;         /* so does NaN, for others to refuse */
    return identity;
}

/* Returns 1 if a matrix is finite and its last row is 0 0 0 1. */
static inline int cohsm__m4_is_affine(const float *m)
{
    int i;
    for (i = 0; i < 16; i++)
        if (!cohsm__finite(m[i])) return 0;
    return m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f && m[15] == 1.0f;
}

/* Writes the inverse of m, which may be out itself, and returns 1. Returns 0, with out untouched, if m is
   singular to float precision; the test compares the determinant with the product of the column lengths and
   is therefore free of scale. The arithmetic is double, since the inverse of a badly scaled matrix is used
   on points. */
static inline int cohsm__m4_affine_inverse(float *out, const float *m)
{
    double n[3][3], r[12], det, size;
    double tx = (double)m[12], ty = (double)m[13], tz = (double)m[14];
    int i, j;

    for (i = 0; i < 9; i++) n[i % 3][i / 3] = (double)m[4 * (i / 3) + i % 3];
    for (i = 0; i < 3; i++)         /* cofactors: rows and columns in turn give them their signs */
        for (j = 0; j < 3; j++)
            r[3 * j + i] = n[(j + 1) % 3][(i + 1) % 3] * n[(j + 2) % 3][(i + 2) % 3] -
                           n[(j + 1) % 3][(i + 2) % 3] * n[(j + 2) % 3][(i + 1) % 3];
    det = n[0][0] * r[0] + n[0][1] * r[1] + n[0][2] * r[2];
    size = sqrt((n[0][0] * n[0][0] + n[1][0] * n[1][0] + n[2][0] * n[2][0]) *
                (n[0][1] * n[0][1] + n[1][1] * n[1][1] + n[2][1] * n[2][1])) *
           sqrt(n[0][2] * n[0][2] + n[1][2] * n[1][2] + n[2][2] * n[2][2]);
    if (!(det > 1e-7 * size || det < -1e-7 * size)) return 0;
    for (i = 0; i < 9; i++) r[i] /= det;
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

/* Returns 1 and writes *scale if m is a rotation times one scale > 0, without mirroring, and a translation.
   Its columns must be of equal length and at right angles within 1e-4, which products of float rotations
   reach. */
static inline int cohsm__m4_is_rigid_uniform(const float *m, float *scale)
{
    cohsm__v3 x = cohsm__v3_load(m), y = cohsm__v3_load(m + 4), z = cohsm__v3_load(m + 8);
    float lx, ly, lz;
    float s, tolerance;

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
    if (fabsf(cohsm__v3_dot(y, z)) > 1e-4f ||
        cohsm__v3_dot(cohsm__v3_cross(x, y), z) < 0.0f) return 0;
    *scale = s;
    return 1;
}

/* ==== src/shared/bytes.h ==== */

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

/* ==== src/shared/crc.h ==== */

/* unit crc: CRC-32 as in zip and PNG (reflected 0xEDB88320) */

/* Returns the checksum of data that follows data with the checksum crc; crc is 0 for the first piece. The
   table has 16 entries: four bits a step are fast enough for files, and the table is small enough to read. */
static inline uint32_t cohsm__crc32(uint32_t crc, const void *data, size_t size)
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

/* Returns |x| with the sign bit of s; s = -0 counts as negative. */
static inline float cohsm__copysign(float x, float s)
{
    return cohsm__from_bits((cohsm__to_bits(x) & 0x7fffffffu) | (cohsm__to_bits(s) & 0x80000000u));
}

/* Returns a if yes is 1 and b if it is 0, without a branch: compilers turn a chain of ?: with one condition
   into a branch, and then do not vectorise the loop round it. */
static inline float cohsm__either(int yes, float a, float b)
{
    uint32_t mask = 0u - (uint32_t)yes;
    return cohsm__from_bits((cohsm__to_bits(a) & mask) | (cohsm__to_bits(b) & ~mask));
}

/* Writes sine and cosine of |x| <= 8192 with an absolute error of 1e-7. As in Cody and Waite, pi/2 has three
   parts, of which the first two times k are exact for |k| < 2^13. */
static inline void cohsm__sincos(float x, float *sine, float *cosine)
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
static inline float cohsm__asin_core(float x, float z)
{
    return x + x * z * (0.1666675393f + z * (0.07495241769f + z * (0.04547709903f + z * (0.02414760004f +
                        z * 0.04221856856f))));
}

/* acos(x) is cohsm__acos_rooted(x, sqrtf(cohsm__acos_square(x))). The square root stands apart, since C compilers do
   not vectorise it. Above a half, asin(x) = pi/2 - 2 asin(sqrt((1 - x) / 2)) keeps acos exact near 0. */
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

/* Returns atan2 with an error of 4e-7, at most 3 ulp. All quadrants, zeros of either sign and infinities are
   as with C's atan2f; atan2(0, 0) is 0. */
static inline float cohsm__atan2(float y, float x)
{
    float ax = fabsf(x), ay = fabsf(y);
    float a, t, z, p;
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

/* ==== src/shared/disc.h ==== */

/* unit disc, needs trig: the square mapped to the disc */

/* Writes where a point s, t of the unit square goes on the unit disc by Shirley and Chiu's concentric map,
   which keeps areas in proportion. */
static inline void cohsm__concentric(float s, float t, float *x, float *y)
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
    cohsm__sincos(phi, &sine, &cosine);
    *x = r * cosine;
    *y = r * sine;
}

/* ==== src/shared/octa.h ==== */

/* unit octa, needs v3 trig: equal-area map between the unit square and the sphere, +Y at its centre */

/* Returns the unit direction of a point of the unit square. The inner diamond is the hemisphere y >= 0;
   neighbouring cells of the square are neighbours on the sphere. Clarberg, "Fast equal-area mapping of the
   (hemi)sphere using SIMD", J. Graphics Tools 13(3), 2008. */
static inline cohsm__v3 cohsm__octa_direction(float u, float v)
{
    float a = 2.0f * u - 1.0f, b = 2.0f * v - 1.0f, x = fabsf(a), z = fabsf(b);
    float d = 1.0f - (x + z), r = 1.0f - fabsf(d);
    float s, c, f;

    cohsm__sincos(r > 0.0f ? ((z - x) / r + 1.0f) * 0.785398163f : 0.0f, &s, &c);
    f = r * sqrtf(2.0f - r * r);
    return cohsm__v3_make(a < 0.0f ? -f * c : f * c, d < 0.0f ? r * r - 1.0f : 1.0f - r * r,
                     b < 0.0f ? -f * s : f * s);
}

/* Writes the point u, v in [0, 1] of a unit direction n. 1 - |y| is computed from x^2 + z^2, which is exact
   near the poles. */
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

/* ==== src/shared/hilbert.h ==== */

/* unit hilbert: Hilbert curves in 1 to 3 dimensions */

/* Writes the cell that has this index on the Hilbert curve through a cube of 2^bits cells a side in `dims`
   (1..3) dimensions. Neighbours on the curve share a face. dims * bits is at most 32, index below 2^(dims *
   bits), and each cell[i] below 2^bits. Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707,
   2004: the bits of the index are dealt out to the axes and Gray-decoded; then exchanges and inversions are
   undone from the finest level up. */
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

/* ==== src/shared/rng.h ==== */

/* unit rng: hashes and random numbers, the same on every machine */

/* Returns a hash by the output function of O'Neill's PCG: Jarzynski and Olano, "Hash functions for GPU
   rendering", JCGT 9(3), 2020. */
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

/* Returns the upper 24 bits as a number in [0, 1). Every such value is a float; the largest is 1 - 2^-24. */
static inline float cohsm__to_unit(uint32_t bits) { return (float)(bits >> 8) * (1.0f / 16777216.0f); }

/* Returns number i, in [0, 1), of the stream (seed, stream). There is no state, so that threads and tiles
   can draw their own numbers. */
static inline float cohsm__random(uint32_t seed, uint32_t stream, uint32_t i)
{
    return cohsm__to_unit(cohsm__hash_combine(cohsm__hash_combine(seed, stream), i));
}

/* ==== src/shared/cpu.h ==== */

/* unit cpu: run-time detection of x86 vector units */

/* COHSM__X86 is 1 if functions with target attributes can be compiled and chosen at run time. COHSM__NO_SIMD, which
   the header defines from its public switch, makes it 0. tcc has no such attributes, so that it is 0 there;
   MSVC needs none. For clang in MSVC's place (clang-cl) it is 0, since this compiler hides the vector types
   unless the whole program is built for them. */
#if defined(COHSM__NO_SIMD) || defined(__TINYC__)
#define COHSM__X86 0
#elif defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
#define COHSM__X86 1
#define COHSM__TARGET_AVX2 __attribute__((target("avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#define COHSM__TARGET_AVX512 \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi,bmi2,lzcnt,popcnt")))
#elif defined(_MSC_VER) && defined(_M_X64) && !defined(__clang__)
#define COHSM__X86 1
#define COHSM__TARGET_AVX2
#define COHSM__TARGET_AVX512
#else
#define COHSM__X86 0
#endif

/* These ask the processor directly: the compilers' own functions ask the same, but add 4.5 KB to every
   program. */
#if COHSM__X86 && defined(_MSC_VER)
#include <intrin.h>
static inline void cohsm__cpu_ask(unsigned leaf, unsigned *r) { __cpuidex((int *)r, (int)leaf, 0); }
static inline unsigned cohsm__cpu_xcr0(void) { return (unsigned)_xgetbv(0); }
#elif COHSM__X86
#include <cpuid.h>
static inline void cohsm__cpu_ask(unsigned leaf, unsigned *r)
{
    __cpuid_count(leaf, 0, r[0], r[1], r[2], r[3]);
}
static inline unsigned cohsm__cpu_xcr0(void)
{
    unsigned low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}
#endif

#if COHSM__X86
/* Returns 1 if all of these bits are set in ebx of cpuid's leaf 7, the processor has FMA and POPCNT, and the
   operating system saves the registers that the bits of xcr0 stand for. Every processor with BMI2 has
   LZCNT. */
static inline int cohsm__cpu_leaf7(unsigned xcr0, unsigned ebx)
{
    const unsigned wanted = 1u << 12 | 1u << 23 | 1u << 27;     /* FMA, POPCNT, OSXSAVE */
    unsigned r[4];
    cohsm__cpu_ask(0, r);
    if (r[0] < 7) return 0;
    cohsm__cpu_ask(1, r);
    if ((r[2] & wanted) != wanted || (cohsm__cpu_xcr0() & xcr0) != xcr0) return 0;
    cohsm__cpu_ask(7, r);
    return (r[1] & ebx) == ebx;
}
/* Asks for AVX2, BMI and BMI2, and for the registers of SSE and AVX. */
static inline int cohsm__cpu_has_avx2(void) { return cohsm__cpu_leaf7(0x06u, 0x00000128u); }
/* Asks for F, DQ, BW and VL of AVX-512 besides, and for its mask registers and wide registers. */
static inline int cohsm__cpu_has_avx512(void) { return cohsm__cpu_leaf7(0xe6u, 0xc0030128u); }
#else
static inline int cohsm__cpu_has_avx2(void) { return 0; }
static inline int cohsm__cpu_has_avx512(void) { return 0; }
#endif

/* ==== src/shared/bits.h ==== */

/* unit bits: counting and finding bits */

/* Returns how many bits of x are set. */
static inline uint32_t cohsm__popcount(uint64_t x)
{
    x -= x >> 1 & 0x5555555555555555u;
    x = (x & 0x3333333333333333u) + (x >> 2 & 0x3333333333333333u);
    x = (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    return (uint32_t)(x * 0x0101010101010101u >> 56);
}

/* Returns eight bytes: each is 1 if the same byte of `bytes`, which lies in 0..127, is at least x, otherwise
   0. */
static inline uint64_t cohsm__bytes_from(uint64_t bytes, uint32_t x)
{
    const uint64_t ones = 0x0101010101010101u, tops = 0x8080808080808080u;
    return (((bytes | tops) - x * ones) & tops) >> 7;
}

/* Returns the position of the set bit that has this number, counted from 0, among the set bits of x; 64 if x
   has fewer. The counts of bits up to each byte give the byte, those up to each bit of that byte the
   position. */
static inline uint32_t cohsm__select_bit(uint64_t x, uint32_t number)
{
    const uint64_t ones = 0x0101010101010101u;
    uint64_t upto;
    uint32_t at;

    number = number < 127 ? number + 1u : 127u;
    upto = x - (x >> 1 & 0x5555555555555555u);
    upto = (upto & 0x3333333333333333u) + (upto >> 2 & 0x3333333333333333u);
    upto = ((upto + (upto >> 4)) & 0x0f0f0f0f0f0f0f0fu) * ones;
    at = 64u - 8u * (uint32_t)(cohsm__bytes_from(upto, number) * ones >> 56);
    if (at == 64) return 64;
    number -= (uint32_t)(upto << 8 >> at) & 255u;
    /* The eight bits of that byte are spread over eight bytes, and counted up to each. */
    upto = (((x >> at & 255u) * ones & 0x8040201008040201u) + 0x7f7f7f7f7f7f7f7fu) >> 7 & ones;
    return at + 8u - (uint32_t)(cohsm__bytes_from(upto * ones, number) * ones >> 56);
}

/* ==== src/shared/simd.h ==== */

/* unit simd, needs cpu: one text of a kernel for every instruction set */

/* A kernel is written once, for cohsm__lanes: COHSM__LANE_COUNT floats, of which the instruction set COHSM__SET
   computes COHSM__WIDTH at a time. What lies between unit simd_begin and the last kernel of a header is compiled
   once for every set that the program may meet. It is first compiled in its place, as set "plain", for what
   the whole program is compiled for (SSE2, NEON, the 128 bits of WebAssembly, or one float at a time). Then,
   if COHSM__SIMD_SETS is 1, the header includes itself with COHSM__SET, COHSM__WIDTH and COHSM__LANE_COUNT defined
   anew: avx2 with 8 lanes, avx512 with 16. cohsm__simd_level returns which set to call. With COHSM__NO_SIMD there
   are no intrinsics; the compiler's own vectors, which are portable, stay if COHSM__COMPILER_VECTORS is
   defined. COHSM__FILE is the header's name; a header pasted into another file cannot include itself: "plain".

   What is compiled several times needs a name for each set. The list below makes cohsm__lanes_add the name
   cohsm__lanes_add_avx2 in set avx2; the header has such a list for its kernels. COHSM__KERNEL stands before a
   kernel, COHSM__IN_KERNEL before what is inlined into kernels.

   Every set gives the same bits, but for cohsm__lanes_muladd, which rounds once in avx2 and avx512, twice
   elsewhere. */
#if defined(COHSM__NO_SIMD) && (!defined(COHSM__COMPILER_VECTORS) || defined(__i386__))
#define COHSM__SCALAR 1
#else
#define COHSM__SCALAR 0
#endif
#if COHSM__X86
#include <immintrin.h>
#define COHSM__SIMD_SETS 1
#else
#define COHSM__SIMD_SETS 0
#endif
#if COHSM__X86 && (defined(__x86_64__) || defined(_M_X64))
#define COHSM__SIMD_X86 1
#define COHSM__SIMD_VECTORS 0
#define COHSM__SIMD_WIDTH 4
#elif !COHSM__X86 && !COHSM__SCALAR && (defined(__GNUC__) || defined(__clang__)) && !defined(__TINYC__)
#define COHSM__SIMD_X86 0
#define COHSM__SIMD_VECTORS 1
#define COHSM__SIMD_WIDTH 4
#else
#define COHSM__SIMD_X86 0
#define COHSM__SIMD_VECTORS 0
#define COHSM__SIMD_WIDTH 1
#endif
#ifdef __has_include
#if !__has_include(COHSM__FILE)
#undef COHSM__SIMD_SETS
#define COHSM__SIMD_SETS 0
#endif
#endif
#if COHSM__SIMD_VECTORS && defined(__aarch64__) && !defined(COHSM__NO_SIMD)
#include <arm_neon.h>
#elif COHSM__SIMD_VECTORS && defined(__wasm_simd128__) && !defined(COHSM__NO_SIMD)
#include <wasm_simd128.h>
#endif

#define COHSM__NAME_OF_SET(name, set) name##_##set
#define COHSM__NAME_IN_SET(name, set) COHSM__NAME_OF_SET(name, set)
#define cohsm__lanes COHSM__NAME_IN_SET(cohsm__lanes, COHSM__SET)
#define cohsm__lane_mask COHSM__NAME_IN_SET(cohsm__lane_mask, COHSM__SET)
#define cohsm__lane_ints COHSM__NAME_IN_SET(cohsm__lane_ints, COHSM__SET)
#define cohsm__piece COHSM__NAME_IN_SET(cohsm__piece, COHSM__SET)
#define cohsm__piece_ints COHSM__NAME_IN_SET(cohsm__piece_ints, COHSM__SET)
#define cohsm__piece_words COHSM__NAME_IN_SET(cohsm__piece_words, COHSM__SET)
#define cohsm__lanes_load COHSM__NAME_IN_SET(cohsm__lanes_load, COHSM__SET)
#define cohsm__lanes_store COHSM__NAME_IN_SET(cohsm__lanes_store, COHSM__SET)
#define cohsm__lanes_all COHSM__NAME_IN_SET(cohsm__lanes_all, COHSM__SET)
#define cohsm__lanes_add COHSM__NAME_IN_SET(cohsm__lanes_add, COHSM__SET)
#define cohsm__lanes_sub COHSM__NAME_IN_SET(cohsm__lanes_sub, COHSM__SET)
#define cohsm__lanes_mul COHSM__NAME_IN_SET(cohsm__lanes_mul, COHSM__SET)
#define cohsm__lanes_div COHSM__NAME_IN_SET(cohsm__lanes_div, COHSM__SET)
#define cohsm__lanes_muladd COHSM__NAME_IN_SET(cohsm__lanes_muladd, COHSM__SET)
#define cohsm__lanes_max COHSM__NAME_IN_SET(cohsm__lanes_max, COHSM__SET)
#define cohsm__lanes_min COHSM__NAME_IN_SET(cohsm__lanes_min, COHSM__SET)
#define cohsm__lanes_sqrt COHSM__NAME_IN_SET(cohsm__lanes_sqrt, COHSM__SET)
#define cohsm__lanes_abs COHSM__NAME_IN_SET(cohsm__lanes_abs, COHSM__SET)
#define cohsm__lanes_greater COHSM__NAME_IN_SET(cohsm__lanes_greater, COHSM__SET)
#define cohsm__lanes_at_least COHSM__NAME_IN_SET(cohsm__lanes_at_least, COHSM__SET)
#define cohsm__lanes_select COHSM__NAME_IN_SET(cohsm__lanes_select, COHSM__SET)
#define cohsm__lanes_keep COHSM__NAME_IN_SET(cohsm__lanes_keep, COHSM__SET)
#define cohsm__lanes_truncate COHSM__NAME_IN_SET(cohsm__lanes_truncate, COHSM__SET)
#define cohsm__lanes_of_ints COHSM__NAME_IN_SET(cohsm__lanes_of_ints, COHSM__SET)
#define cohsm__lanes3 COHSM__NAME_IN_SET(cohsm__lanes3, COHSM__SET)
#define cohsm__lanes3_load COHSM__NAME_IN_SET(cohsm__lanes3_load, COHSM__SET)
#define cohsm__lanes3_load_packed COHSM__NAME_IN_SET(cohsm__lanes3_load_packed, COHSM__SET)
#define cohsm__lanes3_all COHSM__NAME_IN_SET(cohsm__lanes3_all, COHSM__SET)
#define cohsm__lanes3_scale COHSM__NAME_IN_SET(cohsm__lanes3_scale, COHSM__SET)
#define cohsm__lanes3_sub COHSM__NAME_IN_SET(cohsm__lanes3_sub, COHSM__SET)
#define cohsm__lanes3_dot COHSM__NAME_IN_SET(cohsm__lanes3_dot, COHSM__SET)
#define cohsm__mask_and COHSM__NAME_IN_SET(cohsm__mask_and, COHSM__SET)
#define cohsm__mask_or COHSM__NAME_IN_SET(cohsm__mask_or, COHSM__SET)
#define cohsm__mask_any COHSM__NAME_IN_SET(cohsm__mask_any, COHSM__SET)
#define cohsm__mask_bits COHSM__NAME_IN_SET(cohsm__mask_bits, COHSM__SET)
#define cohsm__ints_load COHSM__NAME_IN_SET(cohsm__ints_load, COHSM__SET)
#define cohsm__ints_store COHSM__NAME_IN_SET(cohsm__ints_store, COHSM__SET)
#define cohsm__ints_all COHSM__NAME_IN_SET(cohsm__ints_all, COHSM__SET)
#define cohsm__ints_add COHSM__NAME_IN_SET(cohsm__ints_add, COHSM__SET)
#define cohsm__ints_sub COHSM__NAME_IN_SET(cohsm__ints_sub, COHSM__SET)
#define cohsm__ints_or COHSM__NAME_IN_SET(cohsm__ints_or, COHSM__SET)
#define cohsm__ints_keep COHSM__NAME_IN_SET(cohsm__ints_keep, COHSM__SET)
#define cohsm__ints_equal COHSM__NAME_IN_SET(cohsm__ints_equal, COHSM__SET)

/* Returns 2 if AVX-512 may be used, 1 if AVX2 may be, otherwise 0. */
static inline int cohsm__simd_level(void)
{
    if (!COHSM__SIMD_SETS || !cohsm__cpu_has_avx2()) return 0;
    return cohsm__cpu_has_avx512() ? 2 : 1;
}

/* ==== src/shared/part.h ==== */

/* unit part: the caller's progress within parts of a call, and whether it cancels */

/* The share from..to of a call's progress, 0..1. progress may be NULL. */
typedef struct cohsm__part {
    int (*progress)(void *user, float fraction);
    void *user;
    float from, to;
} cohsm__part;

/* Tells the caller that this fraction of the part is done. Returns not 0 if the caller cancels. progress
   must not be NULL. */
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

/* Returns 1 if the caller cancels before step i of count; the caller is asked every so many steps. */
static inline int cohsm__cancelled(const cohsm__part *p, size_t i, size_t count, size_t every)
{
    return p->progress && i % every == 0 && cohsm__part_tell(p, (float)((double)i / (double)count)) != 0;
}

/* ==== src/shared/message.h ==== */

/* unit message: one line for the caller's log that says why a call failed */

/* COHSM__COLD stands before functions that are needed only by calls that fail: compilers make these functions
   small, and take branches to them for unlikely. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define COHSM__COLD __attribute__((cold))
#else
#define COHSM__COLD
#endif

/* Where a message goes, and the name of the function that failed. If log is NULL, nothing is written. */
typedef struct cohsm__logger {
    void (*log)(void *user, const char *message);
    void *user;
    const char *function;
} cohsm__logger;

typedef struct cohsm__message { char text[256]; size_t used; } cohsm__message;

/* Appends a text; what does not fit is cut off. */
static inline COHSM__COLD void cohsm__message_text(cohsm__message *m, const char *s)
{
    while (*s && m->used + 1 < sizeof m->text) m->text[m->used++] = *s++;
    m->text[m->used] = 0;
}

static inline COHSM__COLD void cohsm__message_count(cohsm__message *m, uint64_t value)
{
    char digits[24];
    size_t at = sizeof digits - 1;
    digits[at] = 0;
    do digits[--at] = (char)('0' + (int)(value % 10));
    while ((value /= 10) != 0);
    cohsm__message_text(m, digits + at);
}

/* Writes six significant digits without the zeros at their end. Returns how many digits are left and writes
   *exponent, the power of ten of the first one. value is finite and above 0. */
static inline COHSM__COLD int cohsm__message_digits(double value, char digits[8], int *exponent)
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
static inline COHSM__COLD void cohsm__message_number(cohsm__message *m, double value)
{
    char digits[8], first[2] = { 0, 0 };
    int exponent, count, i;

    if (value != value) {
        cohsm__message_text(m, "not a number");
        return;
    }
    if (value < 0.0) cohsm__message_text(m, "-");
    if (value < 0.0) value = -value;
    if (!(value > 0.0) || value > 1.7976931348623157e308) {
        cohsm__message_text(m, value > 0.0 ? "infinity" : "0");
        return;
    }
    if (value < 9007199254740992.0 && value - (double)(uint64_t)value <= 0.0) {
        cohsm__message_count(m, (uint64_t)value);
        return;
    }
    count = cohsm__message_digits(value, digits, &exponent);
    first[0] = digits[0];
    if (exponent < -4 || exponent > 9) {
        cohsm__message_text(m, first);
        if (count > 1) cohsm__message_text(m, ".");
        cohsm__message_text(m, digits + 1);
        cohsm__message_text(m, exponent < 0 ? "e-" : "e");
        cohsm__message_count(m, (uint64_t)(exponent < 0 ? -exponent : exponent));
        return;
    }
    if (exponent < 0) cohsm__message_text(m, "0.");
    for (i = exponent; i < -1; i++) cohsm__message_text(m, "0");
    for (i = 0; i < count; i++) {
        if (exponent >= 0 && i == exponent + 1) cohsm__message_text(m, ".");
        first[0] = digits[i];
        cohsm__message_text(m, first);
    }
    for (i = count; i <= exponent; i++) cohsm__message_text(m, "0");
}

/* Begins a line: "FUNCTION: FIELD". */
static inline COHSM__COLD void cohsm__message_begin(cohsm__message *m,
                                          const cohsm__logger *logger, const char *field)
{
    m->used = 0;
    cohsm__message_text(m, logger->function);
    cohsm__message_text(m, ": ");
    cohsm__message_text(m, field);
}

/* Logs "FUNCTION: FIELD TEXT", as in "cohsm_build: mesh.positions is NULL". */
static inline COHSM__COLD void cohsm__log_text(const cohsm__logger *logger, const char *field, const char *text)
{
    cohsm__message m;
    if (!logger->log) return;
    cohsm__message_begin(&m, logger, field);
    cohsm__message_text(&m, " ");
    cohsm__message_text(&m, text);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: FIELD is VALUE; it must be WANTED", as in "cohsm_build: desc.map_side is 3; it must be 0 or
   4..1024". */
static inline COHSM__COLD void cohsm__log_value(const cohsm__logger *logger, const char *field, double value,
                                      const char *wanted)
{
    cohsm__message m;
    if (!logger->log) return;
    cohsm__message_begin(&m, logger, field);
    cohsm__message_text(&m, " is ");
    cohsm__message_number(&m, value);
    cohsm__message_text(&m, "; it must be ");
    cohsm__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: ARRAY[INDEX] WHAT VALUE; it must be WANTED", as in "rsm_gather: normals[17] has the length
   0.5; it must be 1 (0.97..1.03), or 0". */
static inline COHSM__COLD void cohsm__log_element(const cohsm__logger *logger, const char *array, uint64_t index,
                                        const char *what, double value, const char *wanted)
{
    cohsm__message m;
    if (!logger->log) return;
    cohsm__message_begin(&m, logger, array);
    cohsm__message_text(&m, "[");
    cohsm__message_count(&m, index);
    cohsm__message_text(&m, "] ");
    cohsm__message_text(&m, what);
    cohsm__message_text(&m, " ");
    cohsm__message_number(&m, value);
    cohsm__message_text(&m, "; it must be ");
    cohsm__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: ARRAY[INDEX] TEXT", as in "cohsm_merge: shards[3] is NULL". */
static inline COHSM__COLD void cohsm__log_element_text(const cohsm__logger *logger, const char *array, uint64_t index,
                                             const char *text)
{
    cohsm__message m;
    if (!logger->log) return;
    cohsm__message_begin(&m, logger, array);
    cohsm__message_text(&m, "[");
    cohsm__message_count(&m, index);
    cohsm__message_text(&m, "] ");
    cohsm__message_text(&m, text);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: mesh: index 2 of triangle 17 is 90, but the mesh has 80 vertices". position counts the
   indices from 0. */
static inline COHSM__COLD void cohsm__log_index(const cohsm__logger *logger, const char *mesh,
                                      uint64_t position, uint64_t index, uint64_t vertex_count)
{
    cohsm__message m;
    if (!logger->log) return;
    cohsm__message_begin(&m, logger, mesh);
    cohsm__message_text(&m, ": index ");
    cohsm__message_count(&m, position % 3);
    cohsm__message_text(&m, " of triangle ");
    cohsm__message_count(&m, position / 3);
    cohsm__message_text(&m, " is ");
    cohsm__message_count(&m, index);
    cohsm__message_text(&m, ", but the mesh has ");
    cohsm__message_count(&m, vertex_count);
    cohsm__message_text(&m, vertex_count == 1 ? " vertex" : " vertices");
    logger->log(logger->user, m.text);
}

/* ==== src/shared/bound.h ==== */

/* unit bound, needs message: the line for a number that is beyond what an object or an earlier call allows */

/* Logs "FUNCTION: FIELD is VALUE; it must be RELATION BOUND, NAME", as in "cohsm_view: view is 9; it must be
   below 8, the number of views". */
static inline COHSM__COLD void cohsm__log_bound(const cohsm__logger *logger, const char *field, uint64_t value,
                                      const char *relation, uint64_t bound, const char *name)
{
    cohsm__message m;
    m.used = 0;
    cohsm__message_text(&m, relation);
    cohsm__message_text(&m, " ");
    cohsm__message_count(&m, bound);
    cohsm__message_text(&m, ", ");
    cohsm__message_text(&m, name);
    cohsm__log_value(logger, field, (double)value, m.text);
}

/* ==== src/shared/hot.h ==== */

/* unit hot, needs fp_begin: attributes of functions that take most of the time */

/* COHSM__INLINE stands before what must be inlined into kernels of several targets. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define COHSM__INLINE static inline __attribute__((always_inline))
#elif defined(_MSC_VER)
#define COHSM__INLINE static __forceinline
#else
#define COHSM__INLINE static inline
#endif

#if defined(__GNUC__) && !defined(__TINYC__)
#define COHSM__PREFETCH(p) __builtin_prefetch(p)
#else
#define COHSM__PREFETCH(p) (void)(p)
#endif

/* ==== src/shared/mask.h ==== */

/* unit mask: holes of alpha masks, asked for at the samples of rasters */

/* Writes the weights of a triangle's corners where the ray through x, y meets the triangle. c holds x, y and
   w of each corner as the view has them; w is the depth in units of the view's half width, and 1 where rays
   are parallel. A sample that rounding puts beyond an edge is moved onto the edge. */
static inline void cohsm__mask_weights(const double *c, double x, double y, float weights[3])
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

/* ==== src/csm/format.h ==== */

/* ---- format: the block, and what maps keep in memory ---- */

/* The block consists of 32-bit little-endian words, so that one rule serves memory, file, upload and hosts of
   either byte order:

     header        COHSM__HEADER_WORDS words, cohsm__header below
     order table   HILBERT only: place in the sequence of each cell, 16 bits each up to 65,536 cells, else 32
     locations     TABLE and LIST only: 4 floats a cell
     lookup        one word for each 65,536 views (a chunk) and pixel: where its directory begins,
                   or COHSM__CONSTANT | depth where all maps of the chunk store the same depth there
     directories   see "lists" below; filled up to a multiple of 16 words from the beginning
     lines         the blocks of all lists, 16 words each, then 4 words of padding so that readers may load
                   ahead */

enum {
    COHSM__MAGIC = 0x4d534344,          /* "DCSM" */
    COHSM__PACK_MAGIC = 0x50534344,     /* "DCSP", of a packed file */
    COHSM__FAST_MAGIC = 0x46534344,     /* "DCSF", of what cohsm_fast_data returns */
    COHSM__FAST_FLAG = 2,               /* beside self_only, in such a header: the last three sections are
                                           lines, base and at of the trays, where a block has its lookup */
    COHSM__MOST_WORDS = 0x3fffffff,     /* of a block */
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
    uint32_t domain, layers, order, orientation;
    uint32_t side[3], map_count, view_count;
    uint32_t map_side, depth_bits, dimensions;
    uint32_t positional, self_only, pixel_begin, pixel_end;
    uint32_t order_words, location_words, lookup_words;
    uint32_t directory_words, line_words;
    uint32_t segments_low, segments_high;
    float    center[3], radius, depth_far, open_thickness;
    float    origin[3], u[3], v[3], w[3];
    float    dop[2 * COHSM__DOP_AXES];  /* least and greatest extent along each axis of cohsm__dop_axis */
    uint32_t reserved[COHSM__HEADER_WORDS - 71];
} cohsm__header;

typedef char cohsm__header_size[sizeof(cohsm__header) == 4 * COHSM__HEADER_WORDS ? 1 : -1];

/* Returns which kernels to use: 2 those of AVX-512, 1 those of AVX2, 0 those of the instruction set that the
   program is compiled for. */
static int cohsm__simd(void) { return cohsm__simd_level(); }

typedef struct cohsm__trays {           /* the fast layout: see trays.h */
    void           *memory;             /* what the allocator gave, of so many bytes */
    size_t          bytes;
    const void     *data;               /* what cohsm_fast_data returns */
    size_t          data_bytes;
    const uint8_t  *lines;              /* 64-byte aligned; NULL: the layout is compact */
    const uint32_t *base;               /* for each bucket of views and group of pixels: its first line */
    const uint16_t *at;                 /* for each bucket and pixel: where the tray is, from that line on */
    uint32_t        groups;             /* of pixels, in a bucket */
} cohsm__trays;

struct cohsm_maps {
    cohsm__allocator  allocator;
    void             *memory;           /* what the allocator gave */
    const uint32_t   *words;            /* the block, 64-byte aligned in it so that its lines are cache
                                           lines; in the caller's file if memory is NULL */
    cohsm__header     head;
    const uint32_t   *order, *lookup, *directories, *lines;
    const float      *locations;
    uint32_t          range;            /* pixel_end - pixel_begin */
    float            *angles;           /* LATLONG: cos, sin of each column, then of each row */
    float             dop[2 * COHSM__DOP_AXES]; /* in radii about the centre */
    uint16_t          depth_of[512];    /* stored grid value -> 16-bit depth */
    int               simd;             /* cohsm__simd */
    void (*log)(void *user, const char *message);   /* of the system that the maps were made with */
    void             *log_user;
    cohsm__trays      trays;
};

static void cohsm__run_tasks(const cohsm_system *s, size_t count, cohsm_task task, void *context)
{
    size_t i;
    if (s->parallel_for) s->parallel_for(s->user, count, task, context);
    else
        for (i = 0; i < count; i++) task(context, i);
}

/* The caller's allocator, with a count of the bytes that it has given out, for cohsm_stats.peak_bytes. */
typedef struct cohsm__counted_heap { cohsm__allocator allocator; size_t used, peak; } cohsm__counted_heap;

static void *cohsm__heap_alloc(cohsm__counted_heap *h, size_t count, size_t size)
{
    void *p = cohsm__alloc_array(&h->allocator, count, size);
    if (p) {
        h->used += count * size;
        if (h->used > h->peak) h->peak = h->used;
    }
    return p;
}

static void cohsm__heap_free(cohsm__counted_heap *h, void *p, size_t count, size_t size)
{
    if (!p) return;
    h->used -= count * size;
    cohsm__free(&h->allocator, p);
}

/* A system for one step of a call: its progress is a part of the whole's; all else is passed on. */
typedef struct cohsm__step_system { cohsm__part part; cohsm_system whole; } cohsm__step_system;

static void cohsm__step_run(void *user, size_t count, cohsm_task task, void *context)
{
    const cohsm_system *whole = &((const cohsm__step_system *)user)->whole;
    whole->parallel_for(whole->user, count, task, context);
}

static int cohsm__step_progress(void *user, float fraction)
{
    return cohsm__part_tell(&((const cohsm__step_system *)user)->part, fraction);
}

static void cohsm__step_log(void *user, const char *message)
{
    const cohsm_system *whole = &((const cohsm__step_system *)user)->whole;
    whole->log(whole->user, message);
}

/* Turns *system into one whose progress runs from..to of what it was. *step must live as long as it is
   used. */
static void cohsm__system_for_step(cohsm_system *system, cohsm__step_system *step, float from, float to)
{
    step->whole = *system;
    step->part.progress = system->progress;
    step->part.user = system->user;
    step->part.from = from;
    step->part.to = to;
    if (system->parallel_for) system->parallel_for = cohsm__step_run;
    if (system->progress) system->progress = cohsm__step_progress;
    if (system->log) system->log = cohsm__step_log;
    system->user = step;
}

static cohsm__allocator cohsm__allocator_of(const cohsm_system *s)
{
    return cohsm__allocator_make(s->allocator.alloc_fn, s->allocator.free_fn, s->allocator.user);
}

static cohsm__logger cohsm__logger_of(const cohsm_system *s, const char *function)
{
    cohsm__logger log;
    log.log = s ? s->log : NULL;
    log.user = s ? s->user : NULL;
    log.function = function;
    return log;
}

/* Returns the log that maps keep; maps may be NULL. */
static cohsm__logger cohsm__logger_of_maps(const cohsm_maps *m, const char *function)
{
    cohsm__logger log;
    log.log = m ? m->log : NULL;
    log.user = m ? m->log_user : NULL;
    log.function = function;
    return log;
}

static int cohsm__system_valid(const cohsm_system *s)
{
    return cohsm__allocator_valid(s->allocator.alloc_fn, s->allocator.free_fn);
}

/* Logs "FIELD TEXT" and returns the result, for a call that returns it too. */
static cohsm_result cohsm__refuse(const cohsm__logger *log, cohsm_result result, const char *field,
                                  const char *text)
{
    cohsm__log_text(log, field, text);
    return result;
}

/* Logs that a field of a desc or a query is out of range, and returns COHSM_ERR_DESC. */
static cohsm_result cohsm__refuse_value(const cohsm__logger *log, const char *field, double value,
                                        const char *wanted)
{
    cohsm__log_value(log, field, value, wanted);
    return COHSM_ERR_DESC;
}

/* Logs that memory was short, if this is the result of a call whose arguments were right. Returns the
   result. */
static cohsm_result cohsm__log_result(const cohsm__logger *log, cohsm_result result)
{
    if (result == COHSM_ERR_ALLOC) cohsm__log_text(log, "system.allocator", "returned no memory");
    return result;
}

/* Writes the allocator of a system, which may be NULL, and the whole of its progress. Returns 0, and logs so,
   if the allocator has one function of the two. */
static int cohsm__services_of(const cohsm_system *system, const cohsm__logger *log, cohsm__allocator *a,
                              cohsm__part *part)
{
    cohsm_system none;

    if (!system) {
        memset(&none, 0, sizeof none);
        system = &none;
    }
    if (!cohsm__system_valid(system)) {
        cohsm__log_text(log, "system.allocator", "has one function of the two");
        return 0;
    }
    *a = cohsm__allocator_of(system);
    part->progress = system->progress;
    part->user = system->user;
    part->from = 0.0f;
    part->to = 1.0f;
    return 1;
}

static uint32_t cohsm__min_u32(uint32_t a, uint32_t b) { return a < b ? a : b; }
static uint32_t cohsm__max_u32(uint32_t a, uint32_t b) { return a > b ? a : b; }

/* Says whether all floats of a header are finite. Locations so far away that distances overflow make it 0. */
static int cohsm__floats_finite(const cohsm__header *h)
{
    const float *f;
    for (f = h->center; f < h->dop + 2 * COHSM__DOP_AXES; f++)
        if (!cohsm__finite(*f)) return 0;
    return 1;
}

/* How many lists are copied or coded between two calls of progress, which takes milliseconds. */
enum { COHSM__LISTS_COPIED = 4096, COHSM__LISTS_CODED = 64 };

/* ==== src/csm/order.h ==== */

/* ---- order: from cells to places in the sequence ---- */

/* A curve on its way through a grid: out receives the numbers of cells, count how many there are so far. */
typedef struct cohsm__walk { uint32_t *out, count, width; } cohsm__walk;

/* Returns v / 2, rounded down. */
static int cohsm__halve_down(int v) { return v >= 0 ? v / 2 : -((1 - v) / 2); }

static int cohsm__sign(int v) { return v > 0 ? 1 : v < 0 ? -1 : 0; }

/* Walks a Hilbert-like curve through a rectangle of any size: the curve starts at (x, y) and covers the cells
   spanned by the vectors a (along which it ends up) and b. Long rectangles are cut in two along a; others in
   three, as Hilbert's square is in four with the middle two joined. Halves are made even where possible,
   which leaves at most one diagonal step. */
static void cohsm__hilbert_walk(cohsm__walk *walk, int x, int y, int ax, int ay, int bx, int by)
{
    int w = abs(ax + ay), h = abs(bx + by), i;
    int dax = cohsm__sign(ax), day = cohsm__sign(ay), dbx = cohsm__sign(bx), dby = cohsm__sign(by);
    int ax2 = cohsm__halve_down(ax), ay2 = cohsm__halve_down(ay);
    int bx2 = cohsm__halve_down(bx), by2 = cohsm__halve_down(by);

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
    cohsm__hilbert_walk(walk, x + (ax - dax) + (bx2 - dbx), y + (ay - day) + (by2 - dby), -bx2, -by2,
                        -(ax - ax2), -(ay - ay2));
}

/* Writes into cells[i] the cell at place i. Zig-zag takes any size, and so does Hilbert in 1 and 2
   dimensions; in 3 dimensions Hilbert is the cube's curve for powers of two, else layers of the 2-D curve,
   every other one backwards. */
static void cohsm__order_cells(uint32_t *cells, const uint32_t *side, cohsm_order order)
{
    uint32_t n0 = side[0], n1 = side[1], n2 = side[2], n = n0 * n1 * n2;
    uint32_t i, x, y, z;
    uint32_t bits, c[3];
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

/* ==== src/csm/domain.h ==== */

/* ---- domain: D (the mapping from parameters to rays), cells, and axes of their maps ---- */

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

static cohsm__v3 cohsm__affine_point(const cohsm__header *h, float s, float t, float r)
{
    cohsm__v3 p = cohsm__v3_load(h->origin);
    p = cohsm__v3_madd(p, cohsm__v3_load(h->u), s);
    p = cohsm__v3_madd(p, cohsm__v3_load(h->v), t);
    return cohsm__v3_madd(p, cohsm__v3_load(h->w), r);
}

/* Returns D at the parameters s, t, r, for every kind but TABLE and LIST. */
static cohsm__v3 cohsm__map_parameter(const cohsm__header *h, float s, float t, float r)
{
    float sine, cosine, ring;
    float x, y;
    cohsm__v3 p;

    switch (h->domain) {
    case COHSM_DOMAIN_OCTAHEDRAL: return cohsm__octa_direction(s, t);
    case COHSM_DOMAIN_DISC:
        cohsm__concentric(s, t, &x, &y);
        return cohsm__affine_point(h, x, y, 0.0f);
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
    default: return cohsm__affine_point(h, s, t, r);
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
    return cohsm__map_parameter(h, ((float)c[0] + 0.5f) / (float)h->side[0],
                                ((float)c[1] + 0.5f) / (float)h->side[1],
                                ((float)c[2] + 0.5f) / (float)h->side[2]);
}

/* The axes of the image of a direction's map; back points to the light. */
typedef struct cohsm__axes { cohsm__v3 right, up, back; } cohsm__axes;

static cohsm__axes cohsm__axes_of(uint32_t kind, cohsm__v3 d)
{
    cohsm__axes f;
    float s, a, h;

    f.back = d;
    if (kind == COHSM_ORIENTATION_POLAR) {
        h = sqrtf(d.x * d.x + d.z * d.z);
        f.right = h > 1e-6f ? cohsm__v3_make(-d.z / h, 0.0f, d.x / h) : cohsm__v3_make(0.0f, 0.0f, 1.0f);
        f.up = cohsm__v3_cross(f.right, d);
        return f;
    }
    s = kind == COHSM_ORIENTATION_MINIMAL || d.y >= 0.0f ? 1.0f : -1.0f;
    if (s + d.y > -1e-6f && s + d.y < 1e-6f) {       /* MINIMAL at -Y: all rotations are as short */
        f.right = cohsm__v3_make(1.0f, 0.0f, 0.0f);
        f.up = cohsm__v3_make(0.0f, 0.0f, 1.0f);
        return f;
    }
    a = -1.0f / (s + d.y);
    f.right = cohsm__v3_make(1.0f + s * d.x * d.x * a, -s * d.x, s * d.x * d.z * a);
    f.up = cohsm__v3_make(d.x * d.z * a, -d.z, s + d.z * d.z * a);
    return f;
}

/* Returns the polar axes of a LATLONG map from the cosines and sines of its two angles, by which even the
   poles have a right. */
static cohsm__axes cohsm__axes_latlong(float cos_phi, float sin_phi, float cos_theta, float sin_theta)
{
    cohsm__axes f;
    f.right = cohsm__v3_make(-sin_phi, 0.0f, cos_phi);
    f.up = cohsm__v3_make(-cos_theta * cos_phi, sin_theta, -cos_theta * sin_phi);
    f.back = cohsm__v3_make(sin_theta * cos_phi, cos_theta, sin_theta * sin_phi);
    return f;
}

/* Writes cos, sin of each column's azimuth, then of each row's polar angle: 2 (side[0] + side[1]) floats. */
static void cohsm__latlong_angles(const uint32_t *side, float *angles)
{
    uint32_t i;
    for (i = 0; i < side[0]; i++, angles += 2)
        cohsm__sincos((((float)i + 0.5f) / (float)side[0] - 0.5f) * 6.28318531f, angles + 1, angles);
    for (i = 0; i < side[1]; i++, angles += 2)
        cohsm__sincos(((float)i + 0.5f) / (float)side[1] * 3.14159265f, angles + 1, angles);
}

static cohsm__axes cohsm__cell_axes(const cohsm__header *h, const float *table, const float *angles,
                                    uint32_t cell)
{
    const float *column, *row;
    cohsm__axes f;
    if (h->domain != COHSM_DOMAIN_LATLONG)
        return cohsm__axes_of(h->orientation, cohsm__cell_location(h, table, cell));
    column = angles + 2 * (cell % h->side[0]);
    row = angles + 2 * h->side[0] + 2 * (cell / h->side[0]);
    f = cohsm__axes_latlong(column[0], column[1], row[0], row[1]);
    return h->orientation == COHSM_ORIENTATION_POLAR ? f : cohsm__axes_of(h->orientation, f.back);
}

/* Writes the coordinates of q for a face of a cube, on which q lies at x / w and y / w within -1..1. A face
   has the number 2 axis, + 1 if it looks along the negative axis. Pixel x runs along the next axis and y
   along the one after, in every face: so neighbours along an edge need no rotation, and the mirroring of some
   faces does no harm. */
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

/* ==== src/csm/raster.h ==== */

/* ---- raster: the first layers of a triangle mesh ---- */

/* Samples lie at pixel centres; corners are rounded to 1/256 pixel, so that triangles of a shared edge see
   the same corners, and the fill rule gives every sample of that edge to one of them: no sample is counted
   twice or missed. Every bit of the result follows from + - * / and integers; the order of triangles does not
   matter. */

enum { COHSM__CLUSTER = 16, COHSM__SUBPIXEL = 256 };

typedef struct cohsm__soup {            /* triangles in units of the bounding sphere, clusters of 16 */
    float   *v;                         /* of each cluster x0[16] y0[16] z0[16] x1[16] ... z2[16]; the last
                                           cluster is filled up with triangles of no area */
    float   *bounds;                    /* boxes of the clusters in groups of 8: x of the middles of all
                                           eight, then y, z, and in the same way their half sides. After
                                           them come, in groups of 8 too, boxes that each hold 8 clusters */
    const cohsm_mesh *masked;           /* the mesh, if it has a mask; else NULL */
    uint32_t *source;                   /* then the number of each triangle in the mesh */
    uint32_t clusters, triangles;
} cohsm__soup;

typedef struct cohsm__camera {
    int          perspective;
    cohsm__axes  axes;                  /* orthographic: of the image, back towards the light */
    cohsm__v3    eye;                   /* perspective, in units of the bounding sphere about its centre */
    uint32_t     face;
    float        depth_scale;           /* perspective: w (in radii) to depth 0..1 */
} cohsm__camera;

typedef struct cohsm__target {
    uint16_t *z;                        /* `keep` depths a pixel, nearest first; COHSM__INFINITE = no hit */
    uint32_t  keep;                     /* 2 or 4 (the fourth is unused) */
    int       size, row_begin, row_end; /* M, and the rows that are wanted */
} cohsm__target;

/* Enters a depth among the first layers of a pixel, which stay sorted. */
static void cohsm__insert_depth(uint16_t *z, uint32_t keep, uint16_t depth)
{
    uint16_t t;
    if (keep == 2) {                    /* without branches, since nobody can predict them */
        const uint16_t first = z[0], second = z[1], behind = depth > first ? depth : first;
        z[0] = depth < first ? depth : first;
        z[1] = behind < second ? behind : second;
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

/* The mask of the triangle that is drawn. Of its corners there are x and y on the image, whose halves are 1
   wide, and w: x and y are not divided by it. */
typedef struct cohsm__mask {
    const cohsm_mesh *mesh;
    uint32_t          triangle;
    double            corners[9];
} cohsm__mask;

/* Says whether the mask has a hole at the centre of pixel x, y of an image of this size. */
static int cohsm__is_hole(const cohsm__mask *mask, int x, int y, int size)
{
    double scale = 2.0 / (double)size;
    float weights[3];
    cohsm__mask_weights(mask->corners, ((double)x + 0.5) * scale - 1.0, ((double)y + 0.5) * scale - 1.0,
                        weights);
    return !mask->mesh->mask_fn(mask->mesh->user, mask->triangle, weights);
}

/* A corner on the image plane: fixed-point position, and depth or 1/w. */
typedef struct cohsm__corner { int32_t x, y; float z; } cohsm__corner;

/* Says whether the edge from a to b leaves the samples exactly on it to the neighbouring triangle, which sees
   the edge from b to a; else the edge takes these samples. */
static int cohsm__edge_loses(const cohsm__corner *a, const cohsm__corner *b)
{
    return !(b->y > a->y || (b->y == a->y && b->x > a->x));
}

/* Returns twice the area that the edge from a to b makes with the point (x, y); positive on its left. */
static int64_t cohsm__edge_area(const cohsm__corner *a, const cohsm__corner *b, int32_t x, int32_t y)
{
    return (int64_t)(b->x - a->x) * (y - a->y) - (int64_t)(b->y - a->y) * (x - a->x);
}

/* The samples in columns x0..x1 and rows y0..y1. */
typedef struct cohsm__samples { int32_t x0, x1, y0, y1; } cohsm__samples;

/* Finds the samples in the box of a triangle that are on the image and in the wanted rows. Returns 0 if there
   are none. */
static int cohsm__samples_in_box(const cohsm__target *t, const cohsm__corner *p0, const cohsm__corner *p1,
                                 const cohsm__corner *p2, cohsm__samples *s)
{
    int32_t lx = p0->x < p1->x ? p0->x : p1->x, hx = p0->x > p1->x ? p0->x : p1->x;
    int32_t ly = p0->y < p1->y ? p0->y : p1->y, hy = p0->y > p1->y ? p0->y : p1->y;

    if (p2->x < lx) lx = p2->x;
    if (p2->x > hx) hx = p2->x;
    if (p2->y < ly) ly = p2->y;
    if (p2->y > hy) hy = p2->y;
    /* The samples are those x * 256 + 128 within lx..hx; lx and hx are clamped first, since shifts of
       negative numbers are not portable. */
    s->x0 = lx <= 128 ? 0 : (lx + 127) >> 8;
    s->y0 = ly <= 128 + 256 * t->row_begin ? t->row_begin : (ly + 127) >> 8;
    s->x1 = hx < 128 ? -1 : (hx - 128) >> 8;
    s->y1 = hy < 128 ? -1 : (hy - 128) >> 8;
    if (s->x1 >= t->size) s->x1 = t->size - 1;
    if (s->y1 >= t->row_end) s->y1 = t->row_end - 1;
    return s->x0 <= s->x1 && s->y0 <= s->y1;
}

/* Enters the depths of a triangle, sample by sample. mask: NULL = none */
static void cohsm__fill_triangle(const cohsm__target *t, const cohsm__camera *cam, const cohsm__mask *mask,
                                 const cohsm__corner *p0, const cohsm__corner *p1, const cohsm__corner *p2)
{
    int64_t area = (int64_t)(p1->x - p0->x) * (p2->y - p0->y) - (int64_t)(p1->y - p0->y) * (p2->x - p0->x);
    int64_t w0, w1, w2;
    int64_t s0, s1, s2;
    int e0, e1, e2;
    int32_t x, y;
    cohsm__samples box;
    const cohsm__corner *swap;
    float scale, z;

    if (area == 0) return;
    if (area < 0) {
        swap = p1;
        p1 = p2;
        p2 = swap;
        area = -area;
    }
    if (!cohsm__samples_in_box(t, p0, p1, p2, &box)) return;
    s0 = cohsm__edge_area(p1, p2, box.x0 * 256 + 128, box.y0 * 256 + 128);
    s1 = cohsm__edge_area(p2, p0, box.x0 * 256 + 128, box.y0 * 256 + 128);
    s2 = cohsm__edge_area(p0, p1, box.x0 * 256 + 128, box.y0 * 256 + 128);
    e0 = cohsm__edge_loses(p1, p2);
    e1 = cohsm__edge_loses(p2, p0);
    e2 = cohsm__edge_loses(p0, p1);
    scale = 1.0f / (float)area;
    for (y = box.y0; y <= box.y1; y++) {
        w0 = s0;
        w1 = s1;
        w2 = s2;
        for (x = box.x0; x <= box.x1; x++) {
            if (w0 >= e0 && w1 >= e1 && w2 >= e2 && !(mask && cohsm__is_hole(mask, x, y, t->size))) {
                z = ((float)w0 * p0->z + (float)w1 * p1->z + (float)w2 * p2->z) * scale;
                if (cam->perspective) z = cam->depth_scale / z;
                cohsm__insert_depth(t->z + (size_t)t->keep * (size_t)(y * t->size + x), t->keep,
                                    cohsm__depth16(z));
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

static const float *cohsm__cluster(const cohsm__soup *soup, uint32_t i)
{
    return soup->v + (size_t)i * 9 * COHSM__CLUSTER;
}

/* Returns how many groups of eight hold count boxes, which are those of clusters or of 8 clusters each. */
static uint32_t cohsm__groups_of_8(uint32_t count) { return (count + 7u) / 8u; }
static size_t cohsm__bound_count(const cohsm__soup *soup)
{
    uint32_t groups = cohsm__groups_of_8(soup->clusters);
    return (size_t)groups + cohsm__groups_of_8(groups);
}
static float *cohsm__wide_bounds(const cohsm__soup *soup)
{
    return soup->bounds + 48 * (size_t)cohsm__groups_of_8(soup->clusters);
}

/* Returns which of 8 clusters may cover samples of the wanted rows of a perspective view, one bit each. */
static unsigned cohsm__face_sees8(const cohsm__target *t, const cohsm__camera *cam, const float *box)
{
    float half = 0.5f * (float)t->size, low = ((float)t->row_begin + 0.49f) / half - 1.0f;
    float high = ((float)t->row_end - 0.49f) / half - 1.0f;
    float x, y, w;
    float ex, ey, ew;
    unsigned mask = 0;
    int i;

    for (i = 0; i < 8; i++) {
        cohsm__v3 c = cohsm__v3_make(box[i], box[8 + i], box[16 + i]);
        cohsm__face_coordinates(cam->face, cohsm__v3_sub(c, cam->eye), &x, &y, &w);
        cohsm__face_coordinates(cam->face, cohsm__v3_make(box[24 + i], box[32 + i], box[40 + i]),
                                &ex, &ey, &ew);
        ex = fabsf(ex);
        ey = fabsf(ey);
        ew = fabsf(ew);
        if (w + ew > 0.0f && fabsf(x) - w <= ex + ew && y - low * w >= -ey - fabsf(low) * ew &&
            y - high * w <= ey + fabsf(high) * ew)
            mask |= 1u << i;
    }
    return mask;
}

/* Depths wait to be entered until there are many: how many of the lanes that are drawn together hit is
   anybody's guess, and a loop over each few hits ends where no predictor expects it. */
enum { COHSM__MANY = 80, COHSM__QUEUE = COHSM__MANY + 32 };         /* kernels write 16 entries at a time */
typedef struct cohsm__hits {
    int32_t  pixel[COHSM__QUEUE], area[COHSM__QUEUE], depth[COHSM__QUEUE];
    float    sum[COHSM__QUEUE];         /* of the corners' depths, each by its part of the area */
    uint32_t count, fill[15];           /* fills a cache line */
} cohsm__hits;

static void cohsm__insert_hits(const cohsm__target *t, cohsm__hits *hits)
{
    uint32_t i;
    for (i = 0; i < hits->count; i++)
        cohsm__insert_depth(t->z + (size_t)t->keep * (uint32_t)hits->pixel[i], t->keep,
                            (uint16_t)hits->depth[i]);
    hits->count = 0;
}

/* Specks are triangles whose box holds one sample, so that their corners lie up to 255/256 pixel from it. On
   a fine mesh nearly all that hold any are specks. */
typedef struct cohsm__specks {
    int32_t  corner[3][COHSM__QUEUE];   /* as seen from the sample: x in the low half, y in the high half */
    float    z[3][COHSM__QUEUE];
    int32_t  pixel[COHSM__QUEUE];
    uint32_t count, fill[15];           /* fills a cache line */
} cohsm__specks;

/* Triangles whose boxes hold samples wait in a queue until there are many; then as many as there are lanes
   are drawn together. On a fine mesh one triangle in five holds samples, and no branch predictor knows which
   one: a branch after each triangle costs more than setting the triangle up. */
typedef struct cohsm__queue {
    int32_t  x[3][COHSM__QUEUE], y[3][COHSM__QUEUE];
    float    z[3][COHSM__QUEUE];
    uint32_t count, fill[15];           /* fills a cache line */
    cohsm__specks specks;               /* are not among the others */
    cohsm__hits   hits;
} cohsm__queue;

/* Directions of one column of the sphere have one axis to the right: of a mesh whose triangles are smaller
   than a pixel, most have no sample column between their corners and are left out of all these views at
   once. Up to COHSM__ABREAST views are drawn together, a slab of the mesh after the other: of its
   triangles, those that hold a sample column, with x on the images and all three corners. Views of other
   axes are drawn together as well, since each slab is then near when the next one reads it. */
enum { COHSM__ABREAST = 8, COHSM__SLAB = 16 * COHSM__CLUSTER, COHSM__CLUSTERS_AHEAD = 12 };
typedef struct cohsm__slab {
    int32_t  x[3][COHSM__SLAB + 16];    /* kernels write 16 entries at a time */
    int32_t  off[3][COHSM__SLAB + 16];  /* of corners from the middle of the sample column */
    int32_t  column[COHSM__SLAB + 16];  /* the one sample column, or -1 if there are several */
    float    corner[9][COHSM__SLAB + 16];
    uint32_t count, fill[15];           /* fills a cache line */
} cohsm__slab;
typedef struct cohsm__column { cohsm__slab slab; cohsm__queue queue[COHSM__ABREAST]; } cohsm__column;

/* Lists which of COHSM__STRETCH neighbouring clusters are in sight. The list has room for eight more, since
   kernels write eight entries at a time. */
enum { COHSM__STRETCH = 512 };
typedef struct cohsm__sight { uint32_t cluster[COHSM__STRETCH + 8], count; } cohsm__sight;

/* Returns a mask of 8 bits with the first count set. */
static unsigned cohsm__first8(uint32_t count) { return count < 8 ? (1u << count) - 1u : 255u; }

/* ==== src/csm/mesh.h ==== */

/* ---- mesh: checked, normalised triangles ---- */

static const uint32_t *cohsm__corners(const cohsm_mesh *m, size_t triangle, uint32_t *scratch)
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

static cohsm__v3 cohsm__vertex(const cohsm_mesh *m, uint32_t i)
{
    size_t stride = m->vertex_stride ? m->vertex_stride : 12;
    float p[3];
    memcpy(p, (const char *)m->positions + stride * i, sizeof p);
    return cohsm__v3_load(p);
}

static size_t cohsm__corner_count(const cohsm_mesh *m)
{
    return m->indices || m->indices16 ? m->index_count : m->vertex_count;
}

static size_t cohsm__triangle_count(const cohsm_mesh *m) { return cohsm__corner_count(m) / 3; }

static cohsm_result cohsm__check_mesh(const cohsm_mesh *m, const cohsm__logger *log)
{
    size_t i, count;
    uint32_t index;
    cohsm_result result = COHSM_ERR_ARGUMENT;

    count = m ? cohsm__corner_count(m) : 0;
    if (!m) cohsm__log_text(log, "mesh", "is NULL");
    else if (!m->positions) cohsm__log_text(log, "mesh.positions", "is NULL");
    else if (!m->vertex_count) cohsm__log_value(log, "mesh.vertex_count", 0.0, "1 or more");
    else if (m->indices && m->indices16) cohsm__log_text(log, "mesh.indices16", "is set beside indices");
    else if (!cohsm__stride_valid(m->vertex_stride, 12))
        cohsm__log_value(log, "mesh.vertex_stride", (double)m->vertex_stride,
                         "0, or 12 or more and a multiple of 4");
    else if (m->vertex_count > 0x7fffffffu || count > 0x7fffffffu) {
        cohsm__log_value(log, m->vertex_count > 0x7fffffffu ? "mesh.vertex_count" : "mesh.index_count",
                         (double)(m->vertex_count > 0x7fffffffu ? m->vertex_count : count), "below 2^31");
        result = COHSM_ERR_LIMIT;
    } else if (count == 0 || count % 3)
        cohsm__log_value(log, m->indices || m->indices16 ? "mesh.index_count" : "mesh.vertex_count",
                         (double)count, "a multiple of 3, above 0");
    else result = COHSM_OK;
    if (result != COHSM_OK || (!m->indices && !m->indices16)) return result;
    for (i = 0; i < count; i++) {
        index = m->indices ? m->indices[i] : m->indices16[i];
        if (index < m->vertex_count) continue;
        cohsm__log_index(log, "mesh", i, index, m->vertex_count);
        return COHSM_ERR_INPUT;
    }
    return COHSM_OK;
}

/* Says whether a comes before b by x, then y, then z. Copies of a triangle whose corners are sorted so
   compare equal whatever their winding. */
static int cohsm__comes_before(cohsm__v3 a, cohsm__v3 b)
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
        if (cohsm__comes_before(p[i == 1 ? 2 : 1], p[i == 1 ? 1 : 0])) {
            t = p[i == 1 ? 1 : 0];
            p[i == 1 ? 1 : 0] = p[i == 1 ? 2 : 1];
            p[i == 1 ? 2 : 1] = t;
        }
}

static int cohsm__same_corner(cohsm__v3 a, cohsm__v3 b)
{
    return !cohsm__comes_before(a, b) && !cohsm__comes_before(b, a);
}

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

/* Sets used[t] to 1 for the triangles that are rendered, which are finite, have three different corners, and
   are the first of their copies. A copy would put a second depth beside an equal first one, so that hardly
   any two views could share a segment. */
static cohsm_result cohsm__select_triangles(const cohsm_mesh *mesh, uint8_t *used, cohsm__counted_heap *heap,
                                            cohsm_stats *stats)
{
    size_t count = cohsm__triangle_count(mesh), slots = 16, t, s;
    uint32_t *table, scratch[3], scratch2[3];
    int k, copy;

    while (slots < 2 * count) slots *= 2;
    table = (uint32_t *)cohsm__heap_alloc(heap, slots, sizeof *table);
    if (!table) return COHSM_ERR_ALLOC;
    memset(table, 0, slots * sizeof *table);
    for (t = 0; t < count; t++) {
        const uint32_t *c = cohsm__corners(mesh, t, scratch);
        cohsm__v3 p[3], q[3];
        for (k = 0; k < 3; k++) p[k] = cohsm__vertex(mesh, c[k]);
        used[t] = 0;
        if (!cohsm__v3_finite(p[0]) || !cohsm__v3_finite(p[1]) || !cohsm__v3_finite(p[2]) ||
            cohsm__same_corner(p[0], p[1]) || cohsm__same_corner(p[1], p[2]) ||
            cohsm__same_corner(p[2], p[0])) {
            stats->skipped_triangles++;
            continue;
        }
        cohsm__sort3(p);
        for (s = cohsm__hash_corners(p) & (slots - 1), copy = 0; table[s] && !copy;
             s = (s + 1) & (slots - 1)) {
            c = cohsm__corners(mesh, table[s] - 1u, scratch2);
            for (k = 0; k < 3; k++) q[k] = cohsm__vertex(mesh, c[k]);
            cohsm__sort3(q);
            copy = cohsm__same_corner(p[0], q[0]) && cohsm__same_corner(p[1], q[1]) &&
                   cohsm__same_corner(p[2], q[2]);
        }
        if (copy) {
            stats->duplicate_triangles++;
            continue;
        }
        table[s] = (uint32_t)t + 1u;
        used[t] = 1;
        stats->triangles++;
    }
    cohsm__heap_free(heap, table, slots, sizeof *table);
    return stats->triangles ? COHSM_OK : COHSM_ERR_INPUT;
}

/* ==== src/csm/bounds.h ==== */

/* ---- bounds: the sphere and the k-DOP of a mesh ---- */

/* The corners of used triangles, each once, in the order in which the triangles name them. */
typedef struct cohsm__points { float (*at)[3]; size_t count, room; } cohsm__points;

static int cohsm__points_make(cohsm__points *points, const cohsm_mesh *mesh, const uint8_t *used,
                              uint32_t triangles, cohsm__counted_heap *heap)
{
    size_t count = cohsm__triangle_count(mesh), bytes = mesh->vertex_count / 8u + 1u, t;
    uint8_t *met = (uint8_t *)cohsm__heap_alloc(heap, bytes, 1);
    uint32_t scratch[3], i;
    int k;

    points->count = 0;
    points->room = 3 * (size_t)triangles < mesh->vertex_count ? 3 * (size_t)triangles : mesh->vertex_count;
    points->at = (float (*)[3])cohsm__heap_alloc(heap, points->room, sizeof *points->at);
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
    cohsm__heap_free(heap, met, bytes, 1);
    return points->count != 0;
}

static void cohsm__points_free(cohsm__points *points, cohsm__counted_heap *heap)
{
    cohsm__heap_free(heap, points->at, points->room, sizeof *points->at);
}

/* Returns the squared distance of the point that is farthest from the centre, and writes its number; of
   equals the first. */
static double cohsm__farthest(const cohsm__points *points, const double *c, size_t *where)
{
    double far2 = -1.0, d2;
    double x, y, z;
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

/* Finds nearly the smallest sphere about the points: from the middle of their box, the centre goes steps of
   1/2, 1/3, 1/4 ... towards the farthest point (Badoiu and Clarkson, "Smaller core-sets for balls", SODA
   2003). */
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

/* Says whether the sphere holds all points. The radius may be short by a little more than rounding of the
   centre can make it. */
static int cohsm__sphere_holds(const cohsm__points *points, const float *center, float radius)
{
    double c[3];
    size_t i;
    int k;
    for (k = 0; k < 3; k++) c[k] = (double)center[k];
    return cohsm__farthest(points, c, &i) <= (double)radius * (double)radius * 1.0001;
}

/* Returns a direction of the k-DOP. The convex hull of an object is kept as a k-DOP (discrete oriented
   polytope): for each of 13 directions the two planes across it between which the object lies. The directions
   are those from the centre of a cube to its faces, edges and corners. */
static cohsm__v3 cohsm__dop_axis(int i)
{
    static const float axis[COHSM__DOP_AXES][3] = {
        { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 1, 0 }, { 1, -1, 0 }, { 1, 0, 1 }, { 1, 0, -1 },
        { 0, 1, 1 }, { 0, 1, -1 }, { 1, 1, 1 }, { 1, 1, -1 }, { 1, -1, 1 }, { -1, 1, 1 }
    };
    return cohsm__v3_load(axis[i]);
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

/* ==== src/csm/soup.h ==== */

/* ---- soup: triangles sorted in space ---- */

/* Writes the corners of a triangle in units of the sphere. */
static void cohsm__soup_corners(const cohsm_mesh *mesh, size_t triangle, cohsm__v3 center, float inverse,
                                cohsm__v3 *p)
{
    uint32_t scratch[3];
    const uint32_t *corner = cohsm__corners(mesh, triangle, scratch);
    int k;
    for (k = 0; k < 3; k++)
        p[k] = cohsm__v3_scale(cohsm__v3_sub(cohsm__vertex(mesh, corner[k]), center), inverse);
}

/* A triangle and where it lies: `at` is the sum of its corners. */
typedef struct cohsm__spot { float at[3]; uint32_t triangle; } cohsm__spot;

/* Returns which of 256 bins along an axis a triangle falls into. */
static uint32_t cohsm__bin_of(const cohsm__spot *p, int axis, float low, float scale)
{
    return cohsm__min_u32((uint32_t)((p->at[axis] - low) * scale), 255u);
}

/* Moves the first `half` triangles along the longest axis of their box to the front. Triangles are counted in
   256 bins; those in the bin of the limit may go to either side, so that the time is linear whatever the
   mesh. */
static void cohsm__halve_spots(cohsm__spot *p, uint32_t count, uint32_t half)
{
    uint32_t bins[256], i, middle;
    uint32_t left, store, bin;
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
    for (i = 0; i < count; i++) bins[cohsm__bin_of(p + i, axis, low[axis], scale)]++;
    for (middle = 0, left = half; bins[middle] <= left && middle < 255u; middle++) left -= bins[middle];
    for (i = 0, store = 0; i < count; i++) {
        bin = cohsm__bin_of(p + i, axis, low[axis], scale);
        if (bin > middle || (bin == middle && !left)) continue;
        left -= (uint32_t)(bin == middle);
        moved = p[i];
        p[i] = p[store];
        p[store++] = moved;
    }
}

/* Sorts the triangles of a leaf into the order of the mesh: neighbours of a mesh often fare alike, so that
   branches are foreseen better. */
static void cohsm__sort_leaf(cohsm__spot *p, uint32_t count)
{
    uint32_t i, j;
    for (i = 1; i < count; i++) {
        cohsm__spot moved = p[i];
        for (j = i; j && p[j - 1u].triangle > moved.triangle; j--) p[j] = p[j - 1u];
        p[j] = moved;
    }
}

/* Sorts triangles so that neighbours in space stand one after the other: by halves of halves, in whole
   clusters and, above these, in eights of clusters. todo has room for any mesh: a half is no larger than the
   rest by more than a unit. */
static void cohsm__sort_spots(cohsm__spot *p, uint32_t count)
{
    enum { LEAF = COHSM__CLUSTER };
    struct { cohsm__spot *p; uint32_t count; } todo[32];
    uint32_t waiting = 0, unit, half;

    for (;;)
        if (count > LEAF) {
            unit = count > 8 * LEAF ? 8 * LEAF : LEAF;
            half = (count + unit - 1u) / unit / 2u * unit;
            cohsm__halve_spots(p, count, half);
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

/* Writes the box of clusters that lie one after the other, a little enlarged. */
static void cohsm__bound_clusters(const float *v, uint32_t clusters, float *box)
{
    float low[3] = { 2.0f, 2.0f, 2.0f }, high[3] = { -2.0f, -2.0f, -2.0f };
    uint32_t i, k;
    for (i = 0; i < 9 * COHSM__CLUSTER * clusters; i++) {
        k = i / COHSM__CLUSTER % 3;
        low[k] = v[i] < low[k] ? v[i] : low[k];
        high[k] = v[i] > high[k] ? v[i] : high[k];
    }
    for (k = 0; k < 3; k++) {
        box[8 * k] = 0.5f * (low[k] + high[k]);
        box[24 + 8 * k] = 0.5f * (high[k] - low[k]) + 1e-5f;
    }
}

/* Writes a box for every `span` clusters, from bounds on. */
static void cohsm__bound_all_clusters(const cohsm__soup *soup, uint32_t span, float *bounds)
{
    uint32_t i, at;
    for (i = 0, at = 0; i < soup->clusters; i += span, at++)
        cohsm__bound_clusters(cohsm__cluster(soup, i), cohsm__min_u32(span, soup->clusters - i),
                              bounds + 48 * (size_t)(at / 8) + at % 8);
}

static void cohsm__soup_fill(cohsm__soup *soup, const cohsm_mesh *mesh, const uint8_t *used,
                             cohsm__spot *spot, cohsm__v3 center, float inverse)
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
        if (soup->masked) soup->source[n] = spot[n].triangle;
        for (k = 0; k < 3; k++) {
            v = soup->v + (size_t)(n / COHSM__CLUSTER) * 9 * COHSM__CLUSTER + 3 * COHSM__CLUSTER * k +
                n % COHSM__CLUSTER;
            v[0] = p[k].x;
            v[COHSM__CLUSTER] = p[k].y;
            v[2 * COHSM__CLUSTER] = p[k].z;
        }
    }
}

/* Makes the clusters of a mesh: triangles are sorted in space, so that clusters are small and a shard need
   not look into most of them. Returns 0 if memory runs out; cohsm__soup_free is due in either case. */
static int cohsm__soup_make(cohsm__soup *soup, const cohsm_mesh *mesh, const uint8_t *used,
                            uint32_t triangles, const float *center, float radius, cohsm__counted_heap *heap)
{
    cohsm__spot *spot;
    size_t floats;
    int made;

    soup->triangles = triangles;
    soup->clusters = (triangles + COHSM__CLUSTER - 1) / COHSM__CLUSTER;
    floats = (size_t)soup->clusters * 9 * COHSM__CLUSTER;
    soup->v = (float *)cohsm__heap_alloc(heap, floats, sizeof(float));
    soup->bounds = (float *)cohsm__heap_alloc(heap, cohsm__bound_count(soup), 48 * sizeof(float));
    spot = (cohsm__spot *)cohsm__heap_alloc(heap, triangles, sizeof *spot);
    soup->masked = mesh->mask_fn ? mesh : NULL;
    soup->source = NULL;
    if (soup->masked) soup->source = (uint32_t *)cohsm__heap_alloc(heap, triangles, sizeof *soup->source);
    made = soup->v && soup->bounds && spot && (!soup->masked || soup->source);
    if (made) {
        memset(soup->v, 0, floats * sizeof(float));
        memset(soup->bounds, 0, cohsm__bound_count(soup) * 48 * sizeof(float));
        cohsm__soup_fill(soup, mesh, used, spot, cohsm__v3_load(center), 1.0f / radius);
        cohsm__bound_all_clusters(soup, 1, soup->bounds);
        cohsm__bound_all_clusters(soup, 8, cohsm__wide_bounds(soup));
    }
    cohsm__heap_free(heap, spot, triangles, sizeof *spot);
    return made;
}

static void cohsm__soup_free(cohsm__soup *soup, cohsm__counted_heap *heap)
{
    cohsm__heap_free(heap, soup->v, (size_t)soup->clusters * 9 * COHSM__CLUSTER, sizeof(float));
    cohsm__heap_free(heap, soup->bounds, cohsm__bound_count(soup), 48 * sizeof(float));
    cohsm__heap_free(heap, soup->source, soup->triangles, sizeof *soup->source);
    soup->v = soup->bounds = NULL;
    soup->source = NULL;
}

/* ==== src/csm/trays.h ==== */

/* ---- trays: the fast layout ---- */

/* Maps in the fast layout keep, beside the block, a tray for each pixel and bucket of 256 views: the depths
   of the pixel over these views, within one line of 64 bytes, so that a question reads a pointer and one line
   and decodes nothing. Three tables, in the order of their size, which follow a copy of the block's first
   sections in one run of bytes, so that a GPU gets all of it at once:

     lines   64 bytes each, 64-byte aligned: trays
     at      16 bits for each bucket and pixel, the pixel running fastest. Bits 14 and 15: split, the tray
             stands in 2^split lines of its own, one for each 256 >> split views. Bits 0..13: where it begins,
             counted from the line `base` in steps of 2 bytes (split 0) or of lines
     base    32 bits for each bucket and group of 256 pixels: the number of a line

   A tray, or the line of a part of a split tray, is

     1 byte         n, at most 31
     n bytes        the first views of all its segments but the first, rising, counted from the bucket's first
                    view
     n + 1 bytes    codes of the segments: the depth on the block's grid, 2^depth_bits - 1 for infinite, or
                    COHSM__EXACT_CODE
     2 bytes each   the exact depths, low byte first, in the order of their codes

   so that its length is even, and n and the number of exact depths are together at most 31. Segment j holds a
   view if j of the n first views are not above it.

   Depths that do not fit into a line even if a tray is split in eight have n = 31 and codes that are all
   exact, for which no line has room: the byte after n says how many lines further on the 16-bit depths of
   these 32 views stand, low bytes first. So every list can be kept. */

enum {
    COHSM__LINE_BYTES = 64,
    COHSM__BUCKET_BITS = 8,             /* of views */
    COHSM__BUCKET = 1 << COHSM__BUCKET_BITS,
    COHSM__GROUP_BITS = 8,              /* of pixels */
    COHSM__GROUP = 1 << COHSM__GROUP_BITS,
    COHSM__SPLITS = 3,                  /* a bucket's lines at most: 2^3 */
    COHSM__SPREAD_VIEWS = COHSM__BUCKET >> COHSM__SPLITS,
    COHSM__TRAY_FIRSTS = 31,            /* first views and exact depths that a line has room for */
    COHSM__EXACT_CODE = 254
};

/* Returns the tray that holds a view or, of a split tray, the line of its part. */
static inline const uint8_t *cohsm__tray_at(const cohsm_maps *m, uint32_t pixel, uint32_t place)
{
    const cohsm__trays *c = &m->trays;
    const size_t bucket = place >> COHSM__BUCKET_BITS;
    const uint32_t at = c->at[bucket * m->range + pixel], split = at >> 14;
    const uint32_t part = (place & (COHSM__BUCKET - 1u)) >> (COHSM__BUCKET_BITS - split);
    const size_t line = c->base[bucket * c->groups + (pixel >> COHSM__GROUP_BITS)];
    return c->lines + COHSM__LINE_BYTES * (line + part) + ((at & 0x3fffu) << (split ? 6 : 1));
}

static inline uint32_t cohsm__tray_half(const uint8_t *p) { return p[0] | (uint32_t)p[1] << 8; }

/* Says whether a line only tells where the depths of its views stand one by one. */
static inline int cohsm__tray_is_spread(const uint8_t *line)
{
    return line[0] == COHSM__TRAY_FIRSTS && line[COHSM__LINE_BYTES - 1] == COHSM__EXACT_CODE;
}

/* Returns the depth of a view whose code, number j of the codes, is COHSM__EXACT_CODE. */
static uint32_t cohsm__tray_exact(const uint8_t *tray, uint32_t j, uint32_t view)
{
    uint32_t n = tray[0], exact = 0, i;
    if (n == COHSM__TRAY_FIRSTS) {
        tray += COHSM__LINE_BYTES * (size_t)tray[1];
        return cohsm__tray_half(tray + 2u * (view % COHSM__SPREAD_VIEWS));
    }
    for (i = 0; i < j; i++) exact += tray[1u + n + i] == COHSM__EXACT_CODE;
    return cohsm__tray_half(tray + 2u + 2u * n + 2u * exact);
}

/* Returns the 16-bit depth of a view in its tray. */
static inline uint32_t cohsm__tray_depth(const cohsm_maps *m, const uint8_t *tray, uint32_t place)
{
    uint32_t n = tray[0], view = place & (COHSM__BUCKET - 1u);
    uint32_t j = 0, i, code;

    for (i = 1; i <= n; i++) j += tray[i] <= view;
    code = tray[1u + n + j];
    return code == COHSM__EXACT_CODE ? cohsm__tray_exact(tray, j, view) : m->depth_of[code];
}

/* ==== src/csm/lists.h ==== */

/* ---- lists: the format ---- */

/* One pixel's depths over the views of a chunk are piecewise constant: segments, each with a first view and a
   depth. A list is cut into blocks of one cache line each; the last one, its tail, is as short as it can be
   and shares a line with the tails of other lists. A directory says where they are. Its first word is the
   number of the first block's line; its second word holds the count of blocks (low 16 bits), the word in its
   line at which the tail begins (4 bits), and how many lines before the first block's line the tail's line is
   (12 bits); 16 bits follow for the first view of every block but the first. A query so reads lookup and
   directory, which are small and stay in a near cache, and one line of the large rest.

   A block, read as a string of bits from the low end of its first word, is

     8 base, 4 k, 4 width     k and width are the lengths of the low bits and codes below
     64 marks                 Elias-Fano: the block's views fall into buckets of 2^k; for each bucket a 1 for
                              every segment that begins in it, then a 0. The first segment begins at the
                              block's first view
     n x k low bits           the first view of each segment within its bucket
     n x width codes          width 1..9: the depth on the grid, less base; all ones but the last bit mean
                              infinite. width 10..15: a code has width - 9 bits and is a place in a palette of
                              `base` depths. All ones mean exact, in both
     base x 8 bits            the palette, if there is one
     16 bits each             the exact depths, in order

   n is the number of segments. A search finds its bucket by counting zeros, and then compares a few low bits:
   its time is the same whatever the number of segments. */

enum { COHSM__BLOCK_BITS = 32 * COHSM__BLOCK_WORDS, COHSM__MARKS = 64, COHSM__LOW_AT = 16 + COHSM__MARKS,
       COHSM__WIDEST = 9, COHSM__FARTHEST_TAIL = 4095 };

typedef struct cohsm__segment {
    uint16_t first;                     /* view within the chunk */
    uint16_t lo, hi;                    /* grid values that separate the layers; if exact, lo is the depth and
                                           hi unused */
    uint16_t exact;
} cohsm__segment;

/* Reads a field of up to 30 bits of a block, which lies 32 bits or more from the block's begin. The
   function reads the word before the field's last word and never the word after, which may lie in another
   cache line: such a miss would cost more than the whole search. */
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

/* Returns the 16-bit depth of segment j in a block of n. An exact depth has as many exact depths before it as
   there are codes of all ones before j. */
COHSM__INLINE uint32_t cohsm__block_depth(const uint32_t *block, const uint16_t *depth_of, uint32_t n,
                                          uint32_t j)
{
    uint32_t head = block[0], bits = head >> 12 & 15u;
    uint32_t palette = 0u - (uint32_t)(bits > COHSM__WIDEST), ones, codes_at;
    uint32_t code, value, i, rank = 0;

    bits -= (uint32_t)COHSM__WIDEST & palette;
    ones = (1u << bits) - 1u;
    codes_at = COHSM__LOW_AT + n * (head >> 8 & 15u);
    code = cohsm__bits(block, codes_at + j * bits, bits);
    if (code == ones) {
        for (i = 0; i < j; i++) rank += cohsm__bits(block, codes_at + i * bits, bits) == ones;
        return cohsm__bits(block, cohsm__block_fields(block, n).exact_at + 16 * rank, 16);
    }
    /* This place of the table means infinite, as all places from the grid's top on do. */
    value = code + 1u == ones ? 511u : (head & 255u) + code;
    code = cohsm__bits(block, codes_at + ((n * bits + 8u * code) & palette), 8);
    return depth_of[(code & palette) | (value & ~palette)];
}

/* Returns the segment of a block that holds a view. offset is the view less the block's first; at is where
   the view's bucket begins in the marks. The data decides no branches but for rare cases: a mispredicted
   branch costs as much as ten instructions. */
static inline uint32_t cohsm__segment_at(const uint32_t *block, uint64_t marks, uint32_t offset, uint32_t at)
{
    uint32_t k = block[0] >> 8 & 15u, j = at - (offset >> k), mask = (1u << k) - 1u, low = offset & mask;
    uint32_t run, more, lows;

    run = (uint32_t)((marks >> (at & 63u)) & (at < 64 ? 7u : 0u));
    /* This reads the low bits of two segments, or of one and what follows, which are codes and never too
       short. */
    lows = cohsm__bits(block, COHSM__LOW_AT + j * k, 2u * k);
    more = run & (uint32_t)((lows & mask) <= low);
    j += more & 1u;
    more &= run >> 1 & (uint32_t)(lows >> k <= low);
    j += more & 1u;
    if (more & run >> 2 & 1u)
        for (at += 2; at < 64 && (marks >> at & 1u) && cohsm__bits(block, COHSM__LOW_AT + j * k, k) <= low;
             at++)
            j++;
    return j - 1u;
}

static uint32_t cohsm__block_find(const uint32_t *block, uint32_t offset)
{
    uint64_t marks = cohsm__marks(block);
    uint32_t bucket = offset >> (block[0] >> 8 & 15u);
    return cohsm__segment_at(block, marks, offset, bucket ? cohsm__select_bit(~marks, bucket - 1u) + 1u : 0u);
}

/* Returns how many words a block takes, by its exact codes. */
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
    if (b + 1u < cohsm__block_count(directory))
        return lines + COHSM__BLOCK_WORDS * ((size_t)directory[0] + b);
    return lines + COHSM__BLOCK_WORDS * ((size_t)directory[0] - (tail >> 4)) + (tail & 15u);
}

/* Returns the last block of a list that begins at or before the view, and counts the view from there. */
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
    return cohsm__block_depth(block, m->depth_of, cohsm__popcount(cohsm__marks(block)),
                              cohsm__block_find(block, view));
}

static uint32_t cohsm__stored_depth(const cohsm_maps *m, uint32_t pixel, uint32_t place)
{
    const uint32_t *block;
    uint32_t entry;
#ifndef COHSM_WITHOUT_FAST
    if (m->trays.lines) return cohsm__tray_depth(m, cohsm__tray_at(m, pixel, place), place);
#endif
    entry = m->lookup[(size_t)(place >> COHSM__CHUNK_BITS) * m->range + pixel];
    if (entry & COHSM__CONSTANT) return entry & 0xffffu;
    place &= COHSM__CHUNK - 1u;
    block = cohsm__list_block(m, m->directories + entry, &place);
    return cohsm__depth_in_block(m, block, place);
}

/* ==== src/csm/encode.h ==== */

/* ---- encode: segments to lists ---- */

/* The grid of stored depths: values 0..top, of which top means infinite. A stored value lies at most `margin`
   behind the first hit. */
typedef struct cohsm__grid { uint32_t top, margin; } cohsm__grid;

/* Returns the grid value that is stored for an interval lo..hi. The middle leaves the most room on both sides
   (paper 3.1). But a value far behind the first hit lets light through to whatever is there, other objects
   among them, so the value stays within two pixels of the first hit. */
static uint32_t cohsm__choose_value(const cohsm__grid *g, uint32_t lo, uint32_t hi)
{
    uint32_t middle = (lo + hi) / 2u;
    return middle < lo + g->margin ? middle : lo + g->margin;
}

static cohsm__grid cohsm__grid_of(uint32_t depth_bits, uint32_t map_side)
{
    cohsm__grid g;
    g.top = (1u << depth_bits) - 1u;
    g.margin = (2u * g.top + map_side - 1u) / map_side;
    return g;
}

/* A block of the first n segments: how they would be coded, and how many bits that would take. */
typedef struct cohsm__plan {
    uint32_t n, exact;                  /* segments taken so far; those of them with exact depths */
    uint32_t least_hi, greatest_lo;     /* of the intervals of these segments */
    uint32_t k, bits, base;             /* the block's fields, see "lists" */
    uint32_t values, size;              /* grid values that the codes span; bits that the block takes */
    uint32_t palette;                   /* entries of the palette; 0: there is none */
} cohsm__plan;

static void cohsm__plan_start(cohsm__plan *p)
{
    memset(p, 0, sizeof *p);
    p->least_hi = COHSM__INFINITE;
}

/* Returns the greatest grid value of a segment's interval; only what is infinite has the infinite one. */
static uint32_t cohsm__last_value(const cohsm__segment *s, const cohsm__grid *grid)
{
    return s->lo >= grid->top ? grid->top : cohsm__min_u32(s->hi, grid->top - 1u);
}

/* Returns how many values cohsm__pierce finds. It takes the last values of the intervals in ascending order,
   and of intervals that share one, the latest beginning: one that begins behind the value found last needs a
   new value. A block asks this for each segment that it tries to take. */
static uint32_t cohsm__count_values(const cohsm__segment *s, uint32_t n, const cohsm__grid *grid)
{
    uint64_t present[4], bit, left;         /* a bit for each grid value that is the last of an interval */
    uint8_t begin[256];                     /* of those: where the latest of these intervals begins */
    uint32_t i, last, count = 0, at = 0;

    memset(present, 0, sizeof present);
    for (i = 0; i < n; i++) {
        if (s[i].exact) continue;
        last = cohsm__last_value(s + i, grid);
        bit = (uint64_t)1 << (last & 63u);
        if (!(present[last >> 6] & bit) || begin[last] < s[i].lo) begin[last] = (uint8_t)s[i].lo;
        present[last >> 6] |= bit;
    }
    for (i = 0; i < 4; i++)
        for (left = present[i]; left; left &= left - 1u) {
            last = 64u * i + cohsm__popcount(~left & (left - 1u));
            if (count && begin[last] <= at) continue;
            at = last;
            count++;
        }
    return count;
}

/* Finds the fewest grid values with one in each interval: the least hi that is left must be met, and a value
   as large as that meets the most others. Each value then moves to the middle of what its intervals have in
   common. Writes the values, and for each segment the number of its value. */
static void cohsm__pierce(const cohsm__segment *s, uint32_t n, const cohsm__grid *grid, uint8_t *value,
                          uint8_t *code)
{
    uint8_t todo[COHSM__MARKS];
    uint32_t i, count = 0, left = 0;
    uint32_t at, lo;

    for (i = 0; i < n; i++)
        if (!s[i].exact) todo[left++] = (uint8_t)i;
    for (; left; count++) {
        for (i = 0, at = grid->top; i < left; i++)
            at = cohsm__min_u32(at, cohsm__last_value(&s[todo[i]], grid));
        for (i = 0, lo = 0, n = left, left = 0; i < n; i++) {
            if (s[todo[i]].lo <= at) {
                lo = cohsm__max_u32(lo, s[todo[i]].lo);
                code[todo[i]] = (uint8_t)count;
            } else todo[left++] = todo[i];
        }
        value[count] = (uint8_t)cohsm__choose_value(grid, lo, at);
    }
}

/* Computes the bits of a block. Returns 0 if there are too many. */
static int cohsm__plan_size(cohsm__plan *p)
{
    p->size = COHSM__LOW_AT + p->n * (p->k + p->bits) + 8u * p->palette + 16u * p->exact;
    return p->size <= COHSM__BLOCK_BITS;
}

/* Plans the block with a palette. Returns 0 if it does not fit so. */
static int cohsm__plan_palette(cohsm__plan *p, const cohsm__segment *s, const cohsm__grid *grid)
{
    p->palette = cohsm__count_values(s, p->n, grid);
    for (p->bits = 1; (1u << p->bits) - 1u < p->palette; p->bits++) {}
    return p->palette && p->bits <= 15 - COHSM__WIDEST && cohsm__plan_size(p);
}

/* Takes one more segment into a plan; returns 0 if the block would become too long. end is the first view
   after the segment. */
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
    /* This is the narrowest range of grid values with one in each interval: from the least hi to the greatest
       lo. */
    p->base = cohsm__min_u32(p->least_hi, p->greatest_lo);
    p->values = p->least_hi < p->greatest_lo ? p->greatest_lo - p->least_hi + 1u : 1u;
    if (p->least_hi == COHSM__INFINITE) p->base = 0;
    else if (p->least_hi > p->greatest_lo) p->base = cohsm__choose_value(grid, p->greatest_lo, p->least_hi);
    p->palette = 0;
    for (p->bits = 1; (1u << p->bits) - 2u < p->values; p->bits++) {}
    return cohsm__plan_size(p) || cohsm__plan_palette(p, s, grid);
}

static uint32_t cohsm__segment_end(const cohsm__segment *s, size_t i, size_t count, uint32_t views)
{
    return i + 1 < count ? s[i + 1].first : views;
}

/* Plans a block of as many segments as fit; for a tail by whichever coding is shorter. */
static cohsm__plan cohsm__plan_block(const cohsm__segment *s, size_t count, const cohsm__grid *grid,
                                     uint32_t views)
{
    cohsm__plan best, next;
    cohsm__plan_start(&next);
    best = next;
    while (next.n < count && cohsm__plan_take(&next, s, grid, cohsm__segment_end(s, next.n, count, views)))
        best = next;
    next = best;
    if (best.n == count && !best.palette && cohsm__plan_palette(&next, s, grid) && next.size < best.size)
        best = next;
    return best;
}

static uint32_t cohsm__range_code(const cohsm__segment *s, const cohsm__plan *p, const cohsm__grid *grid)
{
    uint32_t value = cohsm__choose_value(grid, s->lo, cohsm__min_u32(s->hi, grid->top - 1u));
    if (s->lo >= grid->top) return (1u << p->bits) - 2u;
    return cohsm__max_u32(p->base, cohsm__min_u32(value, p->base + p->values - 1u)) - p->base;
}

static void cohsm__write_block(uint32_t *block, const cohsm__segment *s, cohsm__plan *p,
                               const cohsm__grid *grid)
{
    uint32_t i, offset, code;
    uint32_t bucket = 0, at = 16;
    uint32_t head = p->palette ? p->palette : p->base;
    uint8_t value[COHSM__MARKS], place[COHSM__MARKS];
    cohsm__fields f;

    cohsm__put_bits(block, 0, 16, head | p->k << 8 | (p->palette ? p->bits + COHSM__WIDEST : p->bits) << 12);
    f = cohsm__block_fields(block, p->n);
    if (p->palette) cohsm__pierce(s, p->n, grid, value, place);
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
    for (i = 0; i < p->palette; i++) cohsm__put_bits(block, f.palette_at + 8 * i, 8, value[i]);
}

/* Returns the most blocks that a list of count segments can have: a block takes 10 segments at least, all of
   them exact, or all that are left. */
static size_t cohsm__blocks_bound(size_t count) { return count / 10 + 1; }

static size_t cohsm__list_bound(size_t count)
{
    return (cohsm__blocks_bound(count) + 2) / 2 + COHSM__BLOCK_WORDS * cohsm__blocks_bound(count);
}

/* Writes a list of two or more segments into zeroed words as the builder keeps it: 16-bit count of blocks and
   first views of all but the first, padded to a word, then the blocks. Returns the words taken. The blocks
   are written after the longest possible beginning first, and then moved to the end of the real one. */
static size_t cohsm__write_list(uint32_t *words, const cohsm__segment *s, size_t count,
                                const cohsm__grid *grid, uint32_t views)
{
    size_t i, blocks = 0;
    size_t gap = (cohsm__blocks_bound(count) + 2) / 2, used = 0, directory;
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

/* ==== src/csm/layout.h ==== */

/* ---- layout: blocks to lines ---- */

/* Gives lists their places. Lists come in order of chunk and pixel, whoever made them, and so always get the
   same places. A dry run with NULL pointers counts, and a second run writes. Tails go where they fit best
   among a few lines that still have room. */

enum { COHSM__OPEN_LINES = 16 };

typedef struct cohsm__layout {
    uint32_t *directories, *lines;      /* NULL: a dry run */
    uint64_t  directory_words, line_count;  /* how many were given out */
    uint64_t  open[COHSM__OPEN_LINES];  /* lines that still have room */
    uint32_t  used[COHSM__OPEN_LINES];  /* words of them that are taken; 0: there is no such line */
} cohsm__layout;

/* Returns a line with room for a tail, near enough to the next list; a new line if there is none. */
static int cohsm__open_line(cohsm__layout *l, uint32_t words)
{
    int i, best = -1, oldest = 0;
    for (i = 0; i < COHSM__OPEN_LINES; i++) {
        if (l->used[i] && l->line_count - l->open[i] > COHSM__FARTHEST_TAIL) l->used[i] = 0;
        if (l->used[i] && l->used[i] + words <= COHSM__BLOCK_WORDS &&
            (best < 0 || l->used[i] > l->used[best]))
            best = i;
    }
    if (best >= 0) return best;
    for (i = 1; i < COHSM__OPEN_LINES; i++)         /* an unused place, else the fullest line gives way */
        if (l->used[oldest] && (!l->used[i] || l->used[i] > l->used[oldest])) oldest = i;
    l->open[oldest] = l->line_count++;
    l->used[oldest] = 0;
    return oldest;
}

/* Lays a list of count blocks: a tail, and before it full blocks. The first views of the blocks are half
   words of firsts, that of block b at firsts_at + b. */
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

/* Lays a list as cohsm__write_list left it. */
static void cohsm__lay_raw(cohsm__layout *l, uint32_t *lookup, const uint32_t *list)
{
    uint32_t count = list[0] & 0xffffu;
    const uint32_t *full = list + (count + 1u) / 2u;
    cohsm__lay_list(l, lookup, count, list, 0, full, full + COHSM__BLOCK_WORDS * (size_t)(count - 1u));
}

/* ==== src/csm/builder.h ==== */

/* ---- builder: layers to segments, one view at a time ---- */

enum {
    COHSM__RANGES = 16,
    COHSM__BATCH = 128,                 /* views that are drawn before they are compressed, the most */
    COHSM__BATCH_SIDE = 128             /* M beyond which a batch has a quarter, for want of memory */
};

typedef struct cohsm__record {          /* a closed segment on its way to a list */
    uint32_t pixel;                     /* within the range; top bit: exact, its depth in lo | hi << 8 */
    uint16_t first;
    uint8_t  lo, hi;
} cohsm__record;
#define COHSM__EXACT 0x80000000u

typedef struct cohsm__page {            /* records, in memory for b->page_records of them */
    struct cohsm__page *next;
    uint32_t count;
    cohsm__record records[1];
} cohsm__page;

typedef struct cohsm__range {           /* neighbouring pixels, compressed by one task */
    uint32_t     begin, end;            /* pixels of the shard */
    cohsm__page *first, *last;          /* the records of the chunk so far */
    cohsm__page *spare;                 /* an empty page, taken from the allocator between tasks */
    uint32_t     next_view, next_pixel; /* of the batch, and of that view */
    int          starved;               /* stopped for want of a page */
    uint64_t     segments, exact, empty, open;
} cohsm__range;

/* The lists of one range of pixels in one chunk, in memory for count words. */
typedef struct cohsm__words { struct cohsm__words *next; size_t count; uint32_t data[1]; } cohsm__words;

#ifndef COHSM_WITHOUT_BUILD
struct cohsm_builder {
    cohsm__counted_heap       heap;
    cohsm_desc        desc;             /* defaults filled in */
    cohsm__header     head;
    uint32_t         *cells;            /* place in the sequence -> cell */
    float            *locations, *angles;
    int32_t          *span;             /* of each pixel of the shard: the grid values that its open segment
                                           can have, lo | hi << 16 */
    uint32_t         *first;            /* its first view within the chunk */
    uint16_t         *batch;            /* batch_views views with `keep` values a pixel: z1, z2, z3, and
                                           the depth where the ray leaves the sphere (Z1Z3_SPHERE only) */
    uint32_t          keep, batch_size, batch_views, batch_begin, batch_count;
    uint32_t          next_view, range_pixels, page_records;
    cohsm__grid       grid;
    float             thickness;        /* desc.open_thickness in 16-bit depths; for maps of positions, as a
                                           share of the depth */
    cohsm__range      ranges[COHSM__RANGES];
    cohsm__words     *lists, *lists_last;
    uint32_t         *lookup;           /* words from the beginning of its piece of lists, until finish */
    size_t            list_words;
    int               simd;             /* which kernels compress */
    int               finished;         /* or failed: it can only be freed */
    int               counting;         /* segments are counted alone; lists are not written */
};
#endif

/* What kernels need to know to narrow the open segments of pixels, and what they count meanwhile. Behind a
   first layer without a second, at depth z, there are slope * z + gap depths that may be stored. */
typedef struct cohsm__narrowing {
    int32_t  top;                       /* the greatest grid value */
    int32_t  miss;                      /* the least depth that a pixel without a hit can store */
    float    slope, gap;
    uint64_t empty, open;               /* as in cohsm__range */
} cohsm__narrowing;
enum { COHSM__NARROWED = 256 };         /* the most pixels that a kernel narrows at a time */

/* Grid value i stands for the depth floor(i 65535 / grid). These return the least i whose depth is at least
   d, and the greatest i whose depth is at most d. */
static uint32_t cohsm__grid_above(uint32_t d, uint32_t grid) { return (d * grid + 65534u) / 65535u; }
static uint32_t cohsm__grid_below(uint32_t d, uint32_t grid) { return ((d + 1u) * grid - 1u) / 65535u; }

/* Ends the open segment of a pixel. With flag 0 its depth is a grid value within lo..hi. A depth right before
   the second layer would let that layer be lit under a bias of one pixel, so the depth stays up to two pixels
   away from that layer, as long as four are left behind the first. */
static void cohsm__close_segment(cohsm_builder *b, cohsm__range *r, uint32_t pixel, uint32_t flag,
                                 uint32_t lo, uint32_t hi)
{
    cohsm__record *c = &r->last->records[r->last->count++];
    uint32_t clear = b->head.positional ? 4u * hi / b->head.map_side + 1u : b->grid.margin;
    if (!flag && hi < b->grid.top)
        hi = hi > lo + 3u * clear ? hi - clear : cohsm__min_u32(hi, lo + 2u * clear);
    c->pixel = (pixel - r->begin) | flag;
    c->first = (uint16_t)b->first[pixel];
    c->lo = (uint8_t)lo;
    c->hi = (uint8_t)hi;
    r->segments++;
}

/* The grid values lo..hi that an open segment can have, in one number. */
static int32_t cohsm__span_pack(uint32_t lo, uint32_t hi) { return (int32_t)(lo | hi << 16); }
static uint32_t cohsm__span_lo(int32_t span) { return (uint32_t)span & 65535u; }
static uint32_t cohsm__span_hi(int32_t span) { return (uint32_t)span >> 16; }

static void cohsm__close_open_segment(cohsm_builder *b, cohsm__range *r, uint32_t pixel)
{
    cohsm__close_segment(b, r, pixel, 0, cohsm__span_lo(b->span[pixel]), cohsm__span_hi(b->span[pixel]));
}

/* Makes sure that the last page of a range has room for the records of so many pixels of one view, which may
   close two segments a pixel: the one that was open before, and one of an exact depth. Returns 0 if a new
   page is needed and there is no spare one. Who counts segments alone keeps no records. */
static int cohsm__page_ready(const cohsm_builder *b, cohsm__range *r, uint32_t pixels)
{
    cohsm__page *p = r->last;
    if (p && b->counting) p->count = 0;
    if (p && p->count + 2 * pixels <= b->page_records) return 1;
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

/* Writes the interval [lo, hi] in which a stored depth must lie: from the first hit to just before the layer
   that bounds it. Returns 1 if that layer lies at the first hit: then z = z1, and the query's bias has to
   keep the surface from shadowing itself. */
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

static size_t cohsm__page_size(const cohsm_builder *b)
{
    return sizeof(cohsm__page) + (size_t)b->page_records * sizeof(cohsm__record);
}

/* Gets a spare page for each range. Allocation happens here, between tasks, since the caller's allocator need
   not be safe to call from several threads. */
static cohsm_result cohsm__take_spares(cohsm_builder *b)
{
    int i;
    for (i = 0; i < COHSM__RANGES; i++) {
        cohsm__range *r = &b->ranges[i];
        if (r->spare || r->begin == r->end) continue;
        r->spare = (cohsm__page *)cohsm__heap_alloc(&b->heap, 1, cohsm__page_size(b));
        if (!r->spare) return COHSM_ERR_ALLOC;
        r->spare->next = NULL;
    }
    return COHSM_OK;
}

static void cohsm__free_pages(cohsm_builder *b, cohsm__page *p)
{
    while (p) {
        cohsm__page *next = p->next;
        cohsm__heap_free(&b->heap, p, 1, cohsm__page_size(b));
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

static uint32_t cohsm__constant_entry(const cohsm__segment *s, const cohsm__grid *grid)
{
    uint32_t value = grid->top;
    if (s->exact) return COHSM__CONSTANT | s->lo;
    if (s->lo < grid->top) value = cohsm__choose_value(grid, s->lo, cohsm__min_u32(s->hi, grid->top - 1u));
    return COHSM__CONSTANT | value * 65535u / grid->top;
}

/* Lists on their way from the records of a range to words. As many ranges as COHSM__WRITERS are written side
   by side: with four, a build from random triangles would take more memory than cohsm_build says. */
enum { COHSM__WRITERS = 2 };
typedef struct cohsm__writer {
    const cohsm__range *r;
    uint32_t           *lookup;         /* of the pixels of the range */
    size_t             *at;             /* for each pixel and one more: its first segment */
    cohsm__segment     *segments;       /* by pixel; views are in order already */
    cohsm__words       *words;          /* room for `bound` of them */
    size_t              total, bound;
} cohsm__writer;

typedef struct cohsm__writing {
    const cohsm_builder *builder;
    uint32_t             views;
    cohsm__writer        writer[COHSM__WRITERS];
} cohsm__writing;

/* Counts the segments of each pixel, and finds where they shall begin. */
static void cohsm__count_task(void *context, size_t index)
{
    cohsm__writer *w = &((cohsm__writing *)context)->writer[index];
    const uint32_t pixels = w->r->end - w->r->begin;
    const cohsm__page *page;
    uint32_t p, i;

    memset(w->at, 0, ((size_t)pixels + 1) * sizeof *w->at);
    for (page = w->r->first; page; page = page->next)
        for (i = 0; i < page->count; i++) w->at[page->records[i].pixel & ~COHSM__EXACT]++;
    for (p = 0; p < pixels; p++) {
        w->bound += w->at[p] > 1 ? cohsm__list_bound(w->at[p]) : 0;
        w->total += w->at[p];
        w->at[p] = w->total - w->at[p];
    }
    w->at[pixels] = w->total;
}

/* Sorts the records of a range by pixel, and writes one list after the other. */
static void cohsm__write_task(void *context, size_t index)
{
    cohsm__writing *writing = (cohsm__writing *)context;
    const cohsm__grid *grid = &writing->builder->grid;
    cohsm__writer *w = &writing->writer[index];
    const uint32_t pixels = w->r->end - w->r->begin;
    const cohsm__page *page;
    size_t used = 0, n = 0;
    uint32_t p, i;

    for (page = w->r->first; page; page = page->next)
        for (i = 0; i < page->count; i++)
            w->segments[w->at[page->records[i].pixel & ~COHSM__EXACT]++] =
                cohsm__segment_of(&page->records[i]);
    memset(w->words->data, 0, 4 * w->bound);
    for (p = 0; p < pixels; n = w->at[p++]) {           /* at[p] is the end of list p by now */
        if (w->at[p] - n == 1) {
            w->lookup[p] = cohsm__constant_entry(w->segments + n, grid);
            continue;
        }
        w->lookup[p] = (uint32_t)used;
        used += cohsm__write_list(w->words->data + used, w->segments + n, w->at[p] - n, grid, writing->views);
    }
    w->words->count = used;
}

/* Appends the lists of a range to those of the builder, without what their bound had too much. */
static cohsm_result cohsm__keep_lists(cohsm_builder *b, const cohsm__words *words)
{
    const size_t used = words->count;
    cohsm__words *exact = (cohsm__words *)cohsm__heap_alloc(&b->heap, 1, sizeof *exact + 4 * used);
    if (!exact) return COHSM_ERR_ALLOC;
    exact->next = NULL;
    exact->count = used;
    memcpy(exact->data, words->data, 4 * used);
    if (b->lists_last) b->lists_last->next = exact;
    else b->lists = exact;
    b->lists_last = exact;
    b->list_words += used;
    return COHSM_OK;
}

/* Writes the lists of `count` ranges. The caller's allocator is asked between tasks, as in
   cohsm__take_spares. */
static cohsm_result cohsm__write_ranges(cohsm_builder *b, cohsm__writing *writing, uint32_t count)
{
    cohsm_result result = COHSM_OK;
    uint32_t i;

    for (i = 0; i < count && result == COHSM_OK; i++) {
        cohsm__writer *w = &writing->writer[i];
        w->at = (size_t *)cohsm__heap_alloc(&b->heap, (size_t)(w->r->end - w->r->begin) + 1, sizeof *w->at);
        if (!w->at) result = COHSM_ERR_ALLOC;
    }
    if (result == COHSM_OK) cohsm__run_tasks(&b->desc.system, count, cohsm__count_task, writing);
    for (i = 0; i < count && result == COHSM_OK; i++) {
        cohsm__writer *w = &writing->writer[i];
        w->segments = (cohsm__segment *)cohsm__heap_alloc(&b->heap, w->total, sizeof *w->segments);
        w->words = (cohsm__words *)cohsm__heap_alloc(&b->heap, 1, sizeof *w->words + 4 * w->bound);
        if (!w->segments || !w->words) result = COHSM_ERR_ALLOC;
    }
    if (result == COHSM_OK) cohsm__run_tasks(&b->desc.system, count, cohsm__write_task, writing);
    for (i = 0; i < count; i++) {
        cohsm__writer *w = &writing->writer[i];
        if (result == COHSM_OK) result = cohsm__keep_lists(b, w->words);
        cohsm__heap_free(&b->heap, w->words, 1, sizeof *w->words + 4 * w->bound);
        cohsm__heap_free(&b->heap, w->segments, w->total, sizeof *w->segments);
        cohsm__heap_free(&b->heap, w->at, (size_t)(w->r->end - w->r->begin) + 1, sizeof *w->at);
    }
    return result;
}

/* Closes the open segments of a range of pixels. */
static void cohsm__close_range(cohsm_builder *b, cohsm__range *r, uint32_t views)
{
    uint32_t p;
    cohsm__page_ready(b, r, r->end - r->begin);
    for (p = r->begin; p < r->end; p++) {
        if (b->first[p] != views) cohsm__close_open_segment(b, r, p);
        b->first[p] = 0;
        b->span[p] = cohsm__span_pack(0, b->grid.top);
    }
}

/* Ends a chunk of views: closes every segment and turns the records into lists. */
static cohsm_result cohsm__close_chunk(cohsm_builder *b)
{
    const uint32_t chunk = (b->next_view - 1u) >> COHSM__CHUNK_BITS;
    const uint32_t views = ((b->next_view - 1u) & (COHSM__CHUNK - 1u)) + 1u;
    uint32_t *lookup = b->lookup + (size_t)chunk * b->range_pixels, i, k, count;
    cohsm_result result = cohsm__take_spares(b);
    cohsm__writing writing;

    for (i = 0; i < COHSM__RANGES && result == COHSM_OK; i += COHSM__WRITERS) {
        memset(&writing, 0, sizeof writing);
        writing.builder = b;
        writing.views = views;
        for (k = i, count = 0; k < i + COHSM__WRITERS; k++) {
            cohsm__range *r = &b->ranges[k];
            if (r->begin == r->end) continue;           /* fewer pixels than ranges */
            cohsm__close_range(b, r, views);
            writing.writer[count].r = r;
            writing.writer[count++].lookup = lookup + r->begin;
        }
        if (!b->counting) result = cohsm__write_ranges(b, &writing, count);
        for (k = i; k < i + COHSM__WRITERS; k++) {
            cohsm__free_pages(b, b->ranges[k].first);
            b->ranges[k].first = b->ranges[k].last = NULL;
        }
    }
    return result;
}

/* ==== src/csm/desc.h ==== */

/* ---- desc: checked, with defaults filled in ---- */

/* Fills in the sides that are 0, and refuses those that the kind cannot have. */
static cohsm_result cohsm__check_sides(cohsm_domain *d, const cohsm__logger *log)
{
    static const char *const name[3] = { "desc.domain.side[0]", "desc.domain.side[1]",
                                         "desc.domain.side[2]" };
    uint32_t *s = d->side, dims, i, fallback;
    uint64_t n = 1;

    if (d->kind == COHSM_DOMAIN_LIST) {
        if (d->location_count == 0 || d->location_count > 1u << 24)
            return cohsm__refuse_value(log, "desc.domain.location_count", (double)d->location_count,
                                       "1..2^24");
        s[0] = (uint32_t)d->location_count;
        s[1] = s[2] = 1;
        return COHSM_OK;
    }
    if (d->kind == COHSM_DOMAIN_TABLE)
        for (i = 0; i < 3; i++) s[i] = s[i] ? s[i] : 1u;
    dims = cohsm__dimensions(d->kind, s);
    fallback = dims == 3 ? 32u : 128u;
    for (i = 0; i < 3; i++) {
        if (i >= dims && s[i] > 1)
            return cohsm__refuse_value(log, name[i], (double)s[i], "0 or 1: the kind has fewer dimensions");
        if (!s[i]) s[i] = i < dims ? fallback : 1u;
        if (s[i] > 4096 && d->kind != COHSM_DOMAIN_TABLE)
            return cohsm__refuse_value(log, name[i], (double)s[i], "0, or 1..4096");
        n *= s[i];
        if (n > 1u << 24)
            return cohsm__refuse_value(log, name[i], (double)s[i],
                                       "less: sides may make 2^24 cells together");
    }
    if (d->kind == COHSM_DOMAIN_OCTAHEDRAL && s[0] != s[1])
        return cohsm__refuse_value(log, name[1], (double)s[1], "side[0]: an octahedral domain is a square");
    if (d->kind == COHSM_DOMAIN_TABLE && d->location_count != n)
        return cohsm__refuse_value(log, "desc.domain.location_count", (double)d->location_count,
                                   "the product of side");
    return COHSM_OK;
}

static cohsm_result cohsm__check_locations(const cohsm_domain *d, const cohsm__logger *log)
{
    static const char field[] = "desc.domain.locations";
    static const char *const coordinate[3] = { "has the x", "has the y", "has the z" };
    const float *p = d->locations;
    size_t i, k;

    if (!p) return cohsm__refuse(log, COHSM_ERR_DESC, field, "is NULL");
    for (i = 0; i < d->location_count; i++, p += 4) {
        if ((p[3] != 0.0f && p[3] != 1.0f) || p[3] != d->locations[3]) {
            cohsm__log_element(log, field, i, "has the w", (double)p[3], "0 for all or 1 for all");
            return COHSM_ERR_INPUT;
        }
        for (k = 0; k < 3; k++)
            if (!cohsm__finite(p[k])) {
                cohsm__log_element(log, field, i, coordinate[k], (double)p[k], "finite");
                return COHSM_ERR_INPUT;
            }
        if (p[3] == 0.0f && cohsm__v3_length(cohsm__v3_normalize(cohsm__v3_load(p))) == 0.0f) {
            cohsm__log_element(log, field, i, "has the length", 0.0, "more: with w = 0 it is a direction");
            return COHSM_ERR_INPUT;
        }
    }
    return COHSM_OK;
}

/* Refuses a vector of the desc with a component that is not finite. */
static cohsm_result cohsm__check_finite3(const float *p, const char *field, const cohsm__logger *log)
{
    int i;
    for (i = 0; i < 3; i++)
        if (!cohsm__finite(p[i])) return cohsm__refuse_value(log, field, (double)p[i], "finite");
    return COHSM_OK;
}

static cohsm_result cohsm__check_shape(const cohsm_domain *d, const cohsm__logger *log)
{
    cohsm__v3 u = cohsm__v3_load(d->u), v = cohsm__v3_load(d->v), w = cohsm__v3_load(d->w);
    cohsm_result result;

    if (cohsm__has_table((uint32_t)d->kind)) return cohsm__check_locations(d, log);
    if (d->kind == COHSM_DOMAIN_LATLONG || d->kind == COHSM_DOMAIN_OCTAHEDRAL) return COHSM_OK;
    result = cohsm__check_finite3(d->origin, "desc.domain.origin", log);
    if (result == COHSM_OK) result = cohsm__check_finite3(d->u, "desc.domain.u", log);
    if (result == COHSM_OK) result = cohsm__check_finite3(d->v, "desc.domain.v", log);
    if (result == COHSM_OK) result = cohsm__check_finite3(d->w, "desc.domain.w", log);
    if (result != COHSM_OK) return result;
    if (!(cohsm__v3_length(u) > 0.0f))
        return cohsm__refuse(log, COHSM_ERR_DESC, "desc.domain.u", "has no length");
    if ((d->kind == COHSM_DOMAIN_RECTANGLE || d->kind == COHSM_DOMAIN_DISC) &&
        !(cohsm__v3_length(cohsm__v3_cross(u, v)) > 0.0f))
        return cohsm__refuse(log, COHSM_ERR_DESC, "desc.domain.u", "and v span no area");
    if (d->kind == COHSM_DOMAIN_VOLUME && !(fabsf(cohsm__v3_dot(cohsm__v3_cross(u, v), w)) > 0.0f))
        return cohsm__refuse(log, COHSM_ERR_DESC, "desc.domain.u", "and v and w span no volume");
    return COHSM_OK;
}

static cohsm_result cohsm__check_kinds(cohsm_desc *d, const cohsm__logger *log)
{
    if (!cohsm__system_valid(&d->system)) {
        cohsm__log_text(log, "desc.system.allocator", "has one function of the two");
        return COHSM_ERR_DESC;
    }
    if ((unsigned)d->domain.kind >= COHSM_DOMAIN_COUNT)
        return cohsm__refuse_value(log, "desc.domain.kind", (double)d->domain.kind, "a COHSM_DOMAIN_...");
    if ((unsigned)d->layers >= COHSM_LAYERS_COUNT)
        return cohsm__refuse_value(log, "desc.layers", (double)d->layers, "a COHSM_LAYERS_...");
    if ((unsigned)d->order >= COHSM_ORDER_COUNT)
        return cohsm__refuse_value(log, "desc.order", (double)d->order, "a COHSM_ORDER_...");
    if ((unsigned)d->orientation >= COHSM_ORIENTATION_COUNT)
        return cohsm__refuse_value(log, "desc.orientation", (double)d->orientation,
                                   "a COHSM_ORIENTATION_...");
#ifdef COHSM_WITHOUT_FAST
    if (d->layout == COHSM_LAYOUT_FAST)
        return cohsm__refuse_value(log, "desc.layout", (double)d->layout,
                                   "another one in a header without fast");
#endif
    if ((unsigned)d->layout >= COHSM_LAYOUT_COUNT)
        return cohsm__refuse_value(log, "desc.layout", (double)d->layout, "a COHSM_LAYOUT_...");
    if (d->domain.kind == COHSM_DOMAIN_DEFAULT) d->domain.kind = COHSM_DOMAIN_LATLONG;
    if (d->layers == COHSM_LAYERS_DEFAULT) d->layers = COHSM_LAYERS_Z1Z2;
    return COHSM_OK;
}

/* Checks a desc and fills in its defaults; order and sphere may stay open until the mesh is known. */
static cohsm_result cohsm__check_desc(cohsm_desc *d, const cohsm__logger *log)
{
    cohsm_result result;
    uint32_t pixels;

    if (cohsm__check_kinds(d, log) != COHSM_OK) return COHSM_ERR_DESC;
    if (!d->map_side) d->map_side = 128;
    if (!d->depth_bits) d->depth_bits = 8;
    if (!(d->open_thickness >= 0.0f))
        return cohsm__refuse_value(log, "desc.open_thickness", (double)d->open_thickness, "0 or more");
    if (d->open_thickness == 0.0f) d->open_thickness = 8.0f;
    if (d->open_thickness > (float)d->map_side) d->open_thickness = (float)d->map_side;
    if (d->map_side < 4 || d->map_side > 1024)
        return cohsm__refuse_value(log, "desc.map_side", (double)d->map_side, "0, or 4..1024");
    if (d->depth_bits < 4 || d->depth_bits > 8)
        return cohsm__refuse_value(log, "desc.depth_bits", (double)d->depth_bits, "0, or 4..8");
    if (cohsm__check_sides(&d->domain, log) != COHSM_OK) return COHSM_ERR_DESC;
    result = cohsm__check_shape(&d->domain, log);
    if (result != COHSM_OK) return result;
    if (d->domain.kind == COHSM_DOMAIN_LIST || d->domain.kind == COHSM_DOMAIN_LINE)
        d->order = COHSM_ORDER_SCANLINE;
    if (cohsm__check_finite3(d->center, "desc.center", log) != COHSM_OK) return COHSM_ERR_DESC;
    if (!cohsm__finite(d->radius) || d->radius < 0.0f)
        return cohsm__refuse_value(log, "desc.radius", (double)d->radius, "0 or more, and finite");
    pixels = d->map_side * d->map_side;
    if (!d->pixel_begin && !d->pixel_end) d->pixel_end = pixels;
    if (d->pixel_begin < d->pixel_end && d->pixel_end <= pixels) return COHSM_OK;
    return cohsm__refuse_value(log, "desc.pixel_end", (double)d->pixel_end,
                               "above pixel_begin, and map_side^2 or less");
}

/* Logs why a build failed, if it did though its desc and mesh were right. Returns the result. */
static cohsm_result cohsm__log_build(const cohsm__logger *log, const cohsm_desc *d, cohsm_result result)
{
    if (result == COHSM_ERR_LIMIT)
        cohsm__log_value(log, "desc.map_side", (double)d->map_side,
                         "less, or domain.side: maps of 4 GiB or more cannot be made");
    if (result == COHSM_ERR_DESC)
        cohsm__log_text(log, "desc.domain", "lies so far away that depths are not finite");
    return cohsm__log_result(log, result);
}

/* Says whether a radius is far enough from the ends of the float range for squares and inverses. */
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
    h->orientation = (uint32_t)d->orientation;
    memcpy(h->side, d->domain.side, sizeof h->side);
    h->map_count = h->side[0] * h->side[1] * h->side[2];
    h->positional = (uint32_t)cohsm__is_positional(&d->domain);
    h->view_count = h->map_count * (h->positional ? 6u : 1u);
    h->map_side = d->map_side;
    h->depth_bits = d->depth_bits;
    h->open_thickness = d->open_thickness;
    h->dimensions = cohsm__dimensions(d->domain.kind, h->side);
    h->self_only = d->self_only != 0;
    h->pixel_begin = d->pixel_begin;
    h->pixel_end = d->pixel_end;
    if (d->order == COHSM_ORDER_HILBERT)
        h->order_words = h->map_count <= 65536 ? (h->map_count + 1) / 2 : h->map_count;
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

/* Returns the distance that depth 1 stands for in maps of positions: as far as anything of the object is from
   any location. */
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
    } else cam.axes = cohsm__cell_axes(h, locations, angles, cell);
    return cam;
}

/* Returns the depth at which the ray through a pixel's centre leaves the bounding sphere. */
static uint16_t cohsm__leave_depth(const cohsm__camera *cam, uint32_t size, uint32_t pixel)
{
    float x = ((float)(pixel % size) + 0.5f) / (float)size * 2.0f - 1.0f;
    float y = ((float)(pixel / size) + 0.5f) / (float)size * 2.0f - 1.0f;
    float a, b, c, disc;
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

/* ==== src/csm/trays_make.h ==== */

/* ---- trays: made from a block ---- */

/* A column is a group of pixels through the buckets of one chunk. Its lists are read in step, bucket by
   bucket, and each bucket's trays are placed in lines of their own. */

enum {
    COHSM__LARGE_LINES = 16 * COHSM__GROUP,     /* room for split trays: 8 lines each, and 8 of depths */
    COHSM__LINE_STEPS = COHSM__LINE_BYTES / 2,
    COHSM__SHARED_LINES = 2 * COHSM__GROUP,     /* lines that 14 bits of steps reach, in which trays of less
                                                   than a line can begin */
    COHSM__NO_TRAY = 0xffff
};

/* A list that is being read: the decoded segments of one of its blocks. */
typedef struct cohsm__cursor {
    const uint32_t *directory;
    uint32_t block, count;              /* the number of the block, and of its segments */
    uint32_t at;                        /* the segment that was read last */
    uint32_t first[COHSM__MARKS + 1];   /* first views within the chunk; the last one is the block's end */
    uint16_t depth[COHSM__MARKS];
} cohsm__cursor;

/* The segments of one pixel in a bucket of views. */
typedef struct cohsm__pieces {
    uint32_t count;
    uint8_t  first[COHSM__BUCKET], code[COHSM__BUCKET];
    uint16_t depth[COHSM__BUCKET];
} cohsm__pieces;

typedef struct cohsm__tray_work {       /* what is needed for one column at a time */
    cohsm__cursor cursor[COHSM__GROUP];
    cohsm__pieces pieces;
    uint8_t       tiny[COHSM__GROUP][COHSM__LINE_BYTES];   /* trays of less than a line */
    uint8_t       large[COHSM__LARGE_LINES][COHSM__LINE_BYTES];
    uint16_t      steps[COHSM__GROUP];  /* the length of each tray in steps of 2 bytes; 0: it is split */
    uint16_t      line[COHSM__GROUP];   /* of a split tray: the number of its first line in `large` */
    uint16_t      split[COHSM__GROUP];  /* of a split tray: it has 2^split parts */
    uint16_t      same[COHSM__GROUP];   /* the pixel whose tray stands for this pixel too, if both have one
                                           segment and the same code; else the pixel itself */
    uint16_t      place[COHSM__GROUP];  /* where the tray begins, in steps from the bucket's first line */
    uint32_t      large_lines;
} cohsm__tray_work;

/* ---- reading lists ---- */

static void cohsm__cursor_decode(cohsm__cursor *c, const cohsm_maps *m, uint32_t views)
{
    const uint32_t *d = c->directory, *block = cohsm__block_at(d, m->lines, c->block);
    const uint32_t begin = c->block ? cohsm__block_first(d, c->block) : 0u, head = block[0];
    const uint64_t marks = cohsm__marks(block);
    const cohsm__fields f = cohsm__block_fields(block, cohsm__popcount(marks));
    const uint32_t ones = (1u << f.bits) - 1u;
    uint32_t j, at, bucket = 0;
    uint32_t exact = f.exact_at, code;

    for (j = 0, at = 0; j < f.n; at++) {
        if (!(marks >> at & 1u)) bucket++;
        else {
            c->first[j] = begin + (bucket << f.k | cohsm__bits(block, COHSM__LOW_AT + j * f.k, f.k));
            j++;
        }
    }
    for (j = 0; j < f.n; j++) {
        code = cohsm__bits(block, f.codes_at + j * f.bits, f.bits);
        if (code == ones) {
            c->depth[j] = (uint16_t)cohsm__bits(block, exact, 16);
            exact += 16;
        } else if (f.palette) c->depth[j] = m->depth_of[cohsm__bits(block, f.palette_at + 8u * code, 8)];
        else c->depth[j] = code + 1u == ones ? (uint16_t)COHSM__INFINITE : m->depth_of[(head & 255u) + code];
    }
    c->count = f.n;
    c->at = 0;
    c->first[f.n] = c->block + 1u < cohsm__block_count(d) ? cohsm__block_first(d, c->block + 1u) : views;
}

static void cohsm__cursor_start(cohsm__cursor *c, const cohsm_maps *m, uint32_t entry, uint32_t views)
{
    memset(c, 0, sizeof *c);
    if (!(entry & COHSM__CONSTANT)) {
        c->directory = m->directories + entry;
        cohsm__cursor_decode(c, m, views);
        return;
    }
    c->count = 1;
    c->depth[0] = (uint16_t)entry;
    c->first[1] = views;
}

static void cohsm__cursor_step(cohsm__cursor *c, const cohsm_maps *m, uint32_t views)
{
    if (++c->at < c->count) return;
    c->block++;
    cohsm__cursor_decode(c, m, views);
}

/* Reads the segments of the views from begin up to end, which is not beyond the chunk. */
static void cohsm__cursor_read(cohsm__cursor *c, const cohsm_maps *m, uint32_t begin, uint32_t end,
                               uint32_t views, cohsm__pieces *pieces)
{
    uint32_t n = 0;

    if (c->first[c->at + 1u] <= begin) cohsm__cursor_step(c, m, views);
    for (;;) {
        const uint16_t depth = c->depth[c->at];
        if (!n || pieces->depth[n - 1u] != depth) {
            pieces->first[n] = (uint8_t)(n ? c->first[c->at] - begin : 0u);
            pieces->depth[n++] = depth;
        }
        if (c->first[c->at + 1u] >= end) break;
        cohsm__cursor_step(c, m, views);
    }
    pieces->count = n;
}

/* ---- trays of a bucket ---- */

static void cohsm__pieces_codes(const cohsm_maps *m, cohsm__pieces *pieces)
{
    const uint32_t top = (1u << m->head.depth_bits) - 1u;
    uint32_t i, code;

    for (i = 0; i < pieces->count; i++) {
        code = (pieces->depth[i] * top + 65534u) / 65535u;
        if (m->depth_of[code] != pieces->depth[i]) code = COHSM__EXACT_CODE;
        pieces->code[i] = (uint8_t)code;
    }
}

/* Returns how many first views and exact depths a tray of the segments from..to - 1 needs. */
static uint32_t cohsm__pieces_load(const cohsm__pieces *pieces, uint32_t from, uint32_t to)
{
    uint32_t load = to - from - 1u, i;
    for (i = from; i < to; i++) load += pieces->code[i] == COHSM__EXACT_CODE;
    return load;
}

/* Writes the segments from..to - 1 as a tray, and returns its bytes. */
static uint32_t cohsm__tray_write(const cohsm__pieces *pieces, uint32_t from, uint32_t to, uint8_t *tray)
{
    uint32_t n = to - from - 1u, i;
    uint8_t *exact = tray + 2u + 2u * n;

    tray[0] = (uint8_t)n;
    for (i = 0; i < n; i++) tray[1u + i] = pieces->first[from + 1u + i];
    for (i = from; i < to; i++) {
        tray[1u + n + i - from] = pieces->code[i];
        if (pieces->code[i] != COHSM__EXACT_CODE) continue;
        *exact++ = (uint8_t)(pieces->depth[i] & 255u);
        *exact++ = (uint8_t)(pieces->depth[i] >> 8);
    }
    return (uint32_t)(exact - tray);
}

/* Finds the segments *from..*to - 1 that lie in a part, one of 2^split of a bucket: the last segment that
   begins at or before the part, and those that begin within it. */
static void cohsm__pieces_part(const cohsm__pieces *pieces, uint32_t split, uint32_t part, uint32_t *from,
                               uint32_t *to)
{
    const uint32_t views = (uint32_t)COHSM__BUCKET >> split, begin = part * views;

    for (*from = 0; *from + 1u < pieces->count && pieces->first[*from + 1u] <= begin; ++*from) continue;
    for (*to = *from + 1u; *to < pieces->count && pieces->first[*to] < begin + views; ++*to) continue;
}

/* Returns the least split by which every part fits into a line; COHSM__SPLITS if none does. */
static uint32_t cohsm__pieces_split(const cohsm__pieces *pieces)
{
    uint32_t split, part, from, to;

    for (split = 1; split < COHSM__SPLITS; split++) {
        for (part = 0; part < 1u << split; part++) {
            cohsm__pieces_part(pieces, split, part, &from, &to);
            if (cohsm__pieces_load(pieces, from, to) > COHSM__TRAY_FIRSTS) break;
        }
        if (part == 1u << split) break;
    }
    return split;
}

/* Writes the depths of all views of a part one by one. */
static void cohsm__tray_list(const cohsm__pieces *pieces, uint32_t from, uint32_t part, uint8_t *line)
{
    uint32_t begin = part * COHSM__SPREAD_VIEWS, i;

    for (i = 0; i < COHSM__SPREAD_VIEWS; i++) {
        while (from + 1u < pieces->count && pieces->first[from + 1u] <= begin + i) from++;
        line[2u * i] = (uint8_t)(pieces->depth[from] & 255u);
        line[2u * i + 1u] = (uint8_t)(pieces->depth[from] >> 8);
    }
}

/* Writes a tray that does not fit into one line into lines of its own. */
static void cohsm__tray_split(cohsm__tray_work *w, uint32_t p)
{
    const uint32_t split = cohsm__pieces_split(&w->pieces), parts = 1u << split;
    uint32_t part, from, to, spread = parts;
    uint8_t(*lines)[COHSM__LINE_BYTES] = w->large + w->large_lines;

    w->steps[p] = 0;
    w->split[p] = (uint16_t)split;
    w->line[p] = (uint16_t)w->large_lines;
    for (part = 0; part < parts; part++) {
        memset(lines[part], 0, COHSM__LINE_BYTES);
        cohsm__pieces_part(&w->pieces, split, part, &from, &to);
        if (cohsm__pieces_load(&w->pieces, from, to) <= COHSM__TRAY_FIRSTS) {
            cohsm__tray_write(&w->pieces, from, to, lines[part]);
            continue;
        }
        memset(lines[part], COHSM__EXACT_CODE, COHSM__LINE_BYTES);
        lines[part][0] = COHSM__TRAY_FIRSTS;
        lines[part][1] = (uint8_t)(spread - part);
        cohsm__tray_list(&w->pieces, from, part, lines[spread++]);
    }
    w->large_lines += spread;
}

/* Makes the trays of all pixels for the bucket that begins at view `begin` of a chunk of so many views. Where
   they stand is decided later. */
static void cohsm__bucket_trays(cohsm__tray_work *w, const cohsm_maps *m, uint32_t pixels, uint32_t begin,
                                uint32_t views)
{
    const uint32_t end = cohsm__min_u32(begin + COHSM__BUCKET, views);
    uint16_t alone[COHSM__BUCKET];      /* for each code, the first pixel with one segment of this code */
    uint32_t p;

    memset(alone, 0xff, sizeof alone);  /* COHSM__NO_TRAY */
    w->large_lines = 0;
    for (p = 0; p < pixels; p++) {
        cohsm__pieces *pieces = &w->pieces;
        cohsm__cursor_read(&w->cursor[p], m, begin, end, views, pieces);
        cohsm__pieces_codes(m, pieces);
        w->same[p] = (uint16_t)p;
        if (cohsm__pieces_load(pieces, 0, pieces->count) > COHSM__TRAY_FIRSTS) {
            cohsm__tray_split(w, p);
            continue;
        }
        w->steps[p] = (uint16_t)(cohsm__tray_write(pieces, 0, pieces->count, w->tiny[p]) / 2u);
        if (pieces->count > 1 || pieces->code[0] == COHSM__EXACT_CODE) continue;
        if (alone[pieces->code[0]] == COHSM__NO_TRAY) alone[pieces->code[0]] = (uint16_t)p;
        w->same[p] = alone[pieces->code[0]];
    }
}

/* ---- places of trays ---- */

/* Lines that still have room, in a list for each number of steps that are left. */
typedef struct cohsm__room {
    uint64_t some;                      /* bit r: a line has r steps left */
    uint16_t head[COHSM__LINE_STEPS + 1], next[COHSM__SHARED_LINES];
} cohsm__room;

static void cohsm__room_add(cohsm__room *r, uint32_t line, uint32_t left)
{
    if (!left) return;
    r->next[line] = r->some >> left & 1u ? r->head[left] : (uint16_t)COHSM__NO_TRAY;
    r->head[left] = (uint16_t)line;
    r->some |= (uint64_t)1 << left;
}

/* Takes out the line with the least room among those that have at least so many steps left, and writes to
   *left how many it has. Returns the line, or COHSM__NO_TRAY if there is none. */
static uint32_t cohsm__room_take(cohsm__room *r, uint32_t steps, uint32_t *left)
{
    const uint64_t fit = r->some >> steps << steps;
    uint32_t line;

    if (!fit) return COHSM__NO_TRAY;
    *left = cohsm__popcount((fit & (0u - fit)) - 1u);
    line = r->head[*left];
    r->head[*left] = r->next[line];
    if (r->head[*left] == COHSM__NO_TRAY) r->some &= ~((uint64_t)1 << *left);
    return line;
}

/* Returns how many steps a line of a split tray leaves free. */
static uint32_t cohsm__line_left(const uint8_t *line)
{
    const uint32_t n = line[0];
    uint32_t i, used = 1u + n;

    if (cohsm__tray_is_spread(line)) return 0;
    for (i = 0; i <= n; i++) used += line[1u + n + i] == COHSM__EXACT_CODE;
    return COHSM__LINE_STEPS - used;
}

/* Puts the first split trays before all other lines, as long as short trays can begin in their lines, and
   opens what is left in these lines for short trays. Returns the number of these lines. */
static uint32_t cohsm__room_start(cohsm__room *r, const cohsm__tray_work *w, uint32_t pixels)
{
    uint32_t p, part, lines = 0, next;

    r->some = 0;
    for (p = 0; p < pixels; p++) {
        if (w->steps[p]) continue;
        next = w->line[p] + (1u << w->split[p]);
        for (part = 0; part < 1u << w->split[p]; part++) {
            const uint8_t *line = w->large[w->line[p] + part];
            if (cohsm__tray_is_spread(line)) next++;
        }
        if (next > COHSM__GROUP) break;
        for (part = 0; part < 1u << w->split[p]; part++)
            cohsm__room_add(r, w->line[p] + part, cohsm__line_left(w->large[w->line[p] + part]));
        lines = next;
    }
    return lines;
}

/* Places the trays, the longest first, each in the line in which it leaves the least room. Returns how many
   lines the bucket has, and writes to *before how many lines of split trays stand before the others. */
static uint32_t cohsm__bucket_place(cohsm__tray_work *w, uint32_t pixels, uint32_t *before)
{
    uint16_t head[COHSM__LINE_STEPS + 1], next[COHSM__GROUP];
    cohsm__room room;
    uint32_t p, steps;
    uint32_t line, left, fresh;

    *before = fresh = cohsm__room_start(&room, w, pixels);
    memset(head, 0xff, sizeof head);    /* COHSM__NO_TRAY */
    for (p = 0; p < pixels; p++) {
        if (!w->steps[p] || w->same[p] != p) continue;
        next[p] = head[w->steps[p]];
        head[w->steps[p]] = (uint16_t)p;
    }
    for (steps = COHSM__LINE_STEPS; steps > 0; steps--)
        for (p = head[steps]; p != COHSM__NO_TRAY; p = next[p]) {
            line = cohsm__room_take(&room, steps, &left);
            if (line == COHSM__NO_TRAY) {
                line = fresh++;
                left = COHSM__LINE_STEPS;
            }
            w->place[p] = (uint16_t)(COHSM__LINE_STEPS * line + COHSM__LINE_STEPS - left);
            cohsm__room_add(&room, line, left - steps);
        }
    return fresh + w->large_lines - *before;
}

/* Copies the trays to their places, and writes where each begins. `to` is the bucket's first line; all its
   lines are zeroed. */
static void cohsm__bucket_write(const cohsm__tray_work *w, uint32_t pixels, uint32_t before, uint32_t lines,
                                uint8_t *to, uint16_t *at)
{
    const uint32_t behind = lines - w->large_lines;     /* lines between the first and the last split trays */
    uint32_t p, line;

    memcpy(to, w->large, (size_t)before * COHSM__LINE_BYTES);
    memcpy(to + (size_t)(before + behind) * COHSM__LINE_BYTES, w->large[before],
           (size_t)(w->large_lines - before) * COHSM__LINE_BYTES);
    for (p = 0; p < pixels; p++) {
        if (w->steps[p]) {
            if (w->same[p] == p) memcpy(to + 2u * w->place[p], w->tiny[p], 2u * (size_t)w->steps[p]);
            at[p] = w->place[w->same[p]];
            continue;
        }
        line = w->line[p] + (w->line[p] < before ? 0u : behind);
        at[p] = (uint16_t)(line | (uint32_t)w->split[p] << 14);
    }
}

/* ==== src/csm/trays_all.h ==== */

/* ---- trays: all of a block, in memory ---- */

/* All columns are gone through twice: once to count their lines, and once to write them. */

enum { COHSM__TRAY_WORKERS = 8 };

typedef struct cohsm__tray_maker {
    const cohsm_maps *maps;
    uint32_t groups, buckets, columns;
    uint32_t first;                     /* the column of the first worker; the others follow */
    int      writing;
    cohsm__tray_work *work;
    uint32_t *lines;                    /* of each column: first their number, then that of its first one */
    size_t    line_count;               /* of all columns */
    uint8_t  *to;                       /* where line 0 is written */
    uint32_t *base;
    uint16_t *at;
} cohsm__tray_maker;

/* Counts the lines of a column or, the second time, writes them. */
static void cohsm__column_trays(const cohsm__tray_maker *k, uint32_t column, cohsm__tray_work *w)
{
    const cohsm_maps *m = k->maps;
    const uint32_t chunk = column / k->groups, group = column % k->groups, pixel = group << COHSM__GROUP_BITS;
    const uint32_t views = cohsm__min_u32(COHSM__CHUNK, m->head.view_count - (chunk << COHSM__CHUNK_BITS));
    const uint32_t pixels = cohsm__min_u32(COHSM__GROUP, m->range - pixel);
    uint32_t p, begin, sum = k->writing ? k->lines[column] : 0u;
    uint32_t lines, before;
    size_t bucket = (size_t)chunk * (COHSM__CHUNK / COHSM__BUCKET);

    for (p = 0; p < pixels; p++)
        cohsm__cursor_start(&w->cursor[p], m, m->lookup[(size_t)chunk * m->range + pixel + p], views);
    for (begin = 0; begin < views; begin += COHSM__BUCKET, bucket++) {
        cohsm__bucket_trays(w, m, pixels, begin, views);
        lines = cohsm__bucket_place(w, pixels, &before);
        if (k->writing) {
            uint8_t *to = k->to + (size_t)sum * COHSM__LINE_BYTES;
            memset(to, 0, (size_t)lines * COHSM__LINE_BYTES);
            cohsm__bucket_write(w, pixels, before, lines, to, k->at + bucket * m->range + pixel);
            k->base[bucket * k->groups + group] = sum;
        }
        sum += lines;
    }
    if (!k->writing) k->lines[column] = sum;
}

static void cohsm__column_task(void *context, size_t index)
{
    const cohsm__tray_maker *k = (const cohsm__tray_maker *)context;
    const uint32_t column = k->first + (uint32_t)index;

    if (column < k->columns) cohsm__column_trays(k, column, k->work + index);
}

/* The layout that is wanted, and the system that runs the tasks. */
typedef struct cohsm__wish {
    cohsm_layout layout;
    size_t       bytes;                 /* of COHSM_LAYOUT_BUDGET */
    const cohsm_system *system;         /* may be NULL */
} cohsm__wish;

static cohsm_result cohsm__run_columns(cohsm__tray_maker *k, const cohsm__wish *wish, uint32_t workers,
                                       cohsm__part part)
{
    for (k->first = 0; k->first < k->columns; k->first += workers) {
        if (cohsm__cancelled(&part, k->first, k->columns, 1)) return COHSM_ERR_CANCELLED;
        if (workers > 1) wish->system->parallel_for(wish->system->user, workers, cohsm__column_task, k);
        else cohsm__column_task(k, 0);
    }
    return COHSM_OK;
}

/* Returns the words of the block's first sections, filled up to whole lines. */
static size_t cohsm__trays_head(const cohsm__header *h)
{
    const size_t words = (size_t)COHSM__HEADER_WORDS + h->order_words + h->location_words;
    return (words + COHSM__BLOCK_WORDS - 1u) / COHSM__BLOCK_WORDS * COHSM__BLOCK_WORDS;
}

/* Returns the bytes of all trays, 0 if there are too many, and turns the number of lines of each column into
   the number of its first line. */
static size_t cohsm__trays_bytes(cohsm__tray_maker *k)
{
    size_t pointers, bases, bytes = 4 * cohsm__trays_head(&k->maps->head);
    uint64_t sum = 0;
    uint32_t i, lines;

    for (i = 0; i < k->columns; i++) {
        lines = k->lines[i];
        k->lines[i] = (uint32_t)sum;
        sum += lines;
        if (sum > 0xffffffffu) return 0;
    }
    if (sum > (SIZE_MAX - bytes) / COHSM__LINE_BYTES - 2u) return 0;
    k->line_count = (size_t)sum;
    bytes += ((size_t)sum + 2u) * COHSM__LINE_BYTES;    /* 2: to begin and to end with a whole line */
    if (!cohsm__mul_size(k->buckets, k->maps->range, &pointers) || !cohsm__mul_size(pointers, 2, &pointers) ||
        !cohsm__mul_size(k->buckets, 4 * (size_t)k->groups, &bases) ||
        !cohsm__add_size(bytes, pointers, &bytes) || !cohsm__add_size(bytes, bases, &bytes))
        return 0;
    return bytes;
}

/* Writes what stands before the lines: the block's first sections, with a header that says what follows. All
   that is what a GPU needs in place of the block, unless it is longer than a block may be. */
static void cohsm__trays_begin(const cohsm__tray_maker *k, uint32_t *words, cohsm__trays *trays)
{
    const size_t pointers = (size_t)k->buckets * k->maps->range, bases = (size_t)k->buckets * k->groups;
    const size_t lines = COHSM__BLOCK_WORDS * k->line_count, first = cohsm__trays_head(&k->maps->head);
    const uint64_t end = (uint64_t)first + lines + bases + (pointers + 1u) / 2u;
    const uint64_t whole = (end + COHSM__BLOCK_WORDS - 1u) / COHSM__BLOCK_WORDS * COHSM__BLOCK_WORDS;
    cohsm__header h = k->maps->head;

    memset(words, 0, 4 * first);
    memcpy(words, k->maps->words, 4 * ((size_t)COHSM__HEADER_WORDS + h.order_words + h.location_words));
    if (whole > COHSM__MOST_WORDS) return;
    h.magic = COHSM__FAST_MAGIC;
    h.words = (uint32_t)whole;
    h.crc = 0;
    h.self_only |= COHSM__FAST_FLAG;
    h.lookup_words = (uint32_t)lines;
    h.directory_words = (uint32_t)bases;
    h.line_words = (uint32_t)((pointers + 1u) / 2u);
    memcpy(words, &h, sizeof h);
    memset(words + (end - 1u), 0, 4 * (size_t)(whole - end + 1u));
    trays->data = words;
    trays->data_bytes = 4 * (size_t)whole;
}

/* Takes memory for the trays, whose lines were counted, and makes them there. */
static cohsm_result cohsm__trays_fill(cohsm__tray_maker *k, const cohsm__wish *wish, uint32_t workers,
                                      cohsm__part part, cohsm__trays *trays)
{
    uint32_t *words;
    cohsm_result result;

    trays->memory = cohsm__alloc(&k->maps->allocator, trays->bytes);
    if (!trays->memory) return COHSM_ERR_ALLOC;
    words = (uint32_t *)(void *)((uint8_t *)trays->memory + COHSM__LINE_BYTES -
                                 (uintptr_t)trays->memory % COHSM__LINE_BYTES);
    cohsm__trays_begin(k, words, trays);
    words += cohsm__trays_head(&k->maps->head);
    k->to = (uint8_t *)words;
    k->base = words + COHSM__BLOCK_WORDS * k->line_count;
    k->at = (uint16_t *)(void *)(k->base + (size_t)k->buckets * k->groups);
    k->writing = 1;
    result = cohsm__run_columns(k, wish, workers, part);
    if (result != COHSM_OK) {
        cohsm__free(&k->maps->allocator, trays->memory);
        return result;
    }
    trays->lines = k->to;
    trays->base = k->base;
    trays->at = k->at;
    trays->groups = k->groups;
    return COHSM_OK;
}

#ifdef COHSM_WITHOUT_FAST
/* Gives maps the log that they keep; their layout is compact in this header. */
static cohsm_result cohsm__lay_out(cohsm_maps *m, const cohsm__wish *wish, cohsm__part part, size_t *peak)
{
    (void)part;
    *peak = 0;
    if (wish->system) {
        m->log = wish->system->log;
        m->log_user = wish->system->user;
    }
    return COHSM_OK;
}
#else
/* Gives maps the layout that is wanted, and the log that they keep; if this fails, their layout stays
   compact. *peak receives the most bytes that were asked for at once, the trays included. */
static cohsm_result cohsm__lay_out(cohsm_maps *m, const cohsm__wish *wish, cohsm__part part, size_t *peak)
{
    const uint32_t workers = wish->system && wish->system->parallel_for ? (uint32_t)COHSM__TRAY_WORKERS : 1u;
    const size_t most = wish->layout == COHSM_LAYOUT_BUDGET ? wish->bytes : SIZE_MAX;
    const size_t block = 4 * (size_t)m->head.words;
    cohsm__trays trays;
    cohsm__tray_maker k;
    cohsm_result result = COHSM_ERR_ALLOC;

    *peak = 0;
    if (wish->system) {
        m->log = wish->system->log;
        m->log_user = wish->system->user;
    }
    if (wish->layout == COHSM_LAYOUT_COMPACT || most < block) return COHSM_OK;
    memset(&trays, 0, sizeof trays);
    memset(&k, 0, sizeof k);
    k.maps = m;
    k.groups = ((m->range - 1u) >> COHSM__GROUP_BITS) + 1u;
    k.buckets = ((m->head.view_count - 1u) >> COHSM__BUCKET_BITS) + 1u;
    k.columns = k.groups * cohsm__chunks(&m->head);
    if ((uint64_t)2 * k.buckets * m->range > most - block) return COHSM_OK;
    k.work = (cohsm__tray_work *)cohsm__alloc_array(&m->allocator, workers, sizeof *k.work);
    k.lines = (uint32_t *)cohsm__alloc_array(&m->allocator, k.columns, sizeof *k.lines);
    if (k.work && k.lines) {
        result = cohsm__run_columns(&k, wish, workers, cohsm__part_of(&part, 0.0f, 0.5f));
        if (result == COHSM_OK) trays.bytes = cohsm__trays_bytes(&k);
        if (result == COHSM_OK && !trays.bytes) result = COHSM_ERR_LIMIT;
        if (result == COHSM_ERR_LIMIT && most < SIZE_MAX) result = COHSM_OK;
        if (result == COHSM_OK && trays.bytes && trays.bytes <= most - block) {
            *peak = trays.bytes + workers * sizeof *k.work + k.columns * sizeof *k.lines;
            result = cohsm__trays_fill(&k, wish, workers, cohsm__part_of(&part, 0.5f, 1.0f), &trays);
            if (result == COHSM_OK) m->trays = trays;
        }
    }
    cohsm__free(&m->allocator, k.lines);
    cohsm__free(&m->allocator, k.work);
    return result;
}
#endif

/* Logs that trays are refused, if that is what the result of laying maps out says. */
static void cohsm__log_layout(const cohsm__logger *log, const char *field, cohsm_result result)
{
    if (result == COHSM_ERR_LIMIT) cohsm__log_text(log, field, "asks for 256 GiB or more of trays");
}

/* Gives maps that were opened or merged their layout and hands them out, or frees them. */
static cohsm_result cohsm__lay_out_opened(cohsm_maps *maps, const cohsm__wish *wish, cohsm__part part,
                                          cohsm_maps **out)
{
    size_t peak;
    cohsm_result result = cohsm__lay_out(maps, wish, part, &peak);

    if (result == COHSM_OK) *out = maps;
    else cohsm_free(maps);
    return result;
}

/* ==== src/csm/assemble.h ==== */

/* ---- block: the finished maps ---- */

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

static void cohsm__dop_in_radii(cohsm_maps *m)
{
    int i;
    for (i = 0; i < 2 * COHSM__DOP_AXES; i++)
        m->dop[i] = (m->head.dop[i] - cohsm__v3_dot(cohsm__dop_axis(i / 2), cohsm__v3_load(m->head.center))) /
                    m->head.radius;
}

/* Finds the sections of a block whose header is sound, and makes the tables that queries read. */
static void cohsm__find_sections(cohsm_maps *m)
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
    for (i = 0; i < 512; i++)
        m->depth_of[i] = (uint16_t)(i < grid ? i * 65535u / grid : (uint32_t)COHSM__INFINITE);
    cohsm__dop_in_radii(m);
    m->simd = cohsm__simd();
    if (m->angles) cohsm__latlong_angles(m->head.side, m->angles);
}

/* A block in memory of the caller's allocator, which promises alignment to 8 bytes only: the words begin at
   the next boundary of a cache line. */
typedef struct cohsm__memory { void *memory; uint32_t *words; } cohsm__memory;

static cohsm__memory cohsm__take_block(const cohsm__allocator *a, uint32_t words)
{
    cohsm__memory b;
    size_t size;

    b.memory = b.words = NULL;
    /* The sum may overflow on 32-bit targets. */
    if (!cohsm__mul_size(words, 4, &size) || !cohsm__add_size(size, 64, &size)) return b;
    b.memory = cohsm__alloc(a, size);
    if (!b.memory) return b;
    b.words = (uint32_t *)(void *)((char *)b.memory + (64u - (uintptr_t)b.memory % 64u));
    memset(b.words, 0, 4 * (size_t)words);
    return b;
}

/* Makes maps of a block in host order whose header is sound. Takes the memory over, or frees it if this
   fails. */
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
            m->angles = (float *)cohsm__alloc_array(a, 2 * ((size_t)m->head.side[0] + m->head.side[1]),
                                                    sizeof(float));
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
    cohsm__find_sections(m);
    *out = m;
    return COHSM_OK;
}

COHSM_DEF void cohsm_free(cohsm_maps *maps)
{
    cohsm__allocator a;
    if (!maps) return;
    a = maps->allocator;
    cohsm__free(&a, maps->trays.memory);
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

/* Lays out all lists of a builder. lookup says where each list begins in its piece; the call replaces that by
   where the list's directory is. */
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

/* Sets the lengths of the last sections from a dry run of the layout. */
static cohsm_result cohsm__size_block(cohsm__header *h, const cohsm__layout *l)
{
    uint64_t before = (uint64_t)COHSM__HEADER_WORDS + h->order_words + h->location_words + h->lookup_words;
    uint64_t directories = l->directory_words, lines = COHSM__BLOCK_WORDS * l->line_count + COHSM__PADDING;
    directories += (0u - (before + directories)) % COHSM__BLOCK_WORDS;
    if (before + directories + lines > COHSM__MOST_WORDS) return COHSM_ERR_LIMIT;
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

static void cohsm__seal_block(uint32_t *words, const cohsm__header *h)
{
    memcpy(words, h, sizeof *h);
    words[3] = cohsm__block_crc(words, h->words);
}

/* Writes the block of a builder into words, which are zeroed and as many as the header says. */
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
    cohsm__seal_block(words, h);
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

/* Returns the bytes that maps with this header take in the compact layout. */
static size_t cohsm__maps_bytes(const cohsm__header *h)
{
    return 4 * (size_t)h->words + 64 + sizeof(cohsm_maps) +
           8 * ((size_t)h->side[0] + h->side[1]) * (h->domain == COHSM_DOMAIN_LATLONG);
}

/* Makes the maps of a builder, and fills in every field of stats but those of the mesh. */
static cohsm_result cohsm__finish_maps(cohsm_builder *b, cohsm_maps **out, cohsm_stats *stats)
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
    stats->peak_bytes = b->heap.used + cohsm__maps_bytes(h);
    if (stats->peak_bytes < b->heap.peak) stats->peak_bytes = b->heap.peak;
    block = cohsm__take_block(&b->heap.allocator, h->words);
    if (!block.words) return COHSM_ERR_ALLOC;
    cohsm__assemble(b, block.words);
    return cohsm__maps_make(&b->heap.allocator, block, out);
}

#ifndef COHSM_WITHOUT_BUILD
/* Gives finished maps the layout of their desc; if this fails, frees them and logs why. `held` is how many
   bytes the builder still has. */
static cohsm_result cohsm__lay_out_built(cohsm_maps **maps, const cohsm_desc *d, size_t held,
                                         cohsm_stats *stats, const cohsm__logger *log)
{
    const cohsm__header *h = &(*maps)->head;
    cohsm__part whole;
    cohsm__wish wish;
    cohsm_result result;
    size_t peak;

    wish.layout = d->layout;
    wish.bytes = d->layout_bytes;
    wish.system = &d->system;
    memset(&whole, 0, sizeof whole);            /* the build has told its progress */
    result = cohsm__lay_out(*maps, &wish, whole, &peak);
    if (peak) peak += held + cohsm__maps_bytes(h);
    if (stats->peak_bytes < peak) stats->peak_bytes = peak;
    if (result != COHSM_OK) cohsm_free(*maps);
    cohsm__log_layout(log, "desc.layout", result);
    return cohsm__log_result(log, result);
}

COHSM_DEF cohsm_result cohsm_builder_finish(cohsm_builder *b, cohsm_maps **out, cohsm_stats *stats)
{
    cohsm_maps *maps = NULL;
    cohsm_stats s;
    cohsm_result result;
    cohsm__logger log;

    if (!b) return COHSM_ERR_ARGUMENT;
    log = cohsm__logger_of(&b->desc.system, "cohsm_builder_finish");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (b->finished)
        return cohsm__refuse(&log, COHSM_ERR_ORDER, "the builder", "has ended, or failed before");
    if (b->next_view != b->head.view_count || b->batch_count) {
        cohsm__log_value(&log, "the number of views that were added",
                         (double)(b->batch_begin + b->batch_count), "cohsm_builder_view_count(builder)");
        return COHSM_ERR_ORDER;
    }
    memset(&s, 0, sizeof s);
    result = cohsm__finish_maps(b, &maps, &s);
    if (result != COHSM_OK) return cohsm__log_build(&log, &b->desc, result);
    result = cohsm__lay_out_built(&maps, &b->desc, b->heap.used, &s, &log);
    if (result != COHSM_OK) return result;
    *out = maps;
    b->finished = 1;
    if (stats) *stats = s;
    return COHSM_OK;
}
#endif

/* ==== src/csm/facts.h ==== */

/* ---- facts: what maps say about themselves ---- */

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
    out->orientation = (cohsm_orientation)h->orientation;
    memcpy(out->side, h->side, sizeof out->side);
    out->map_count = h->map_count;
    out->view_count = h->view_count;
    out->map_side = h->map_side;
    out->depth_bits = h->depth_bits;
    out->dimensions = h->dimensions;
    out->positional = (int)h->positional;
    out->self_only = (int)h->self_only;
    out->pixel_begin = h->pixel_begin;
    out->pixel_end = h->pixel_end;
    memcpy(out->center, h->center, sizeof out->center);
    out->radius = h->radius;
    out->depth_far = h->depth_far;
    out->segment_count = (uint64_t)h->segments_high << 32 | h->segments_low;
    out->bytes = 4 * (size_t)h->words;
    out->layout = m->trays.lines ? COHSM_LAYOUT_FAST : COHSM_LAYOUT_COMPACT;
    out->fast_bytes = m->trays.bytes;
    out->memory_bytes = cohsm__maps_bytes(h) - (m->memory ? 0 : out->bytes + 64) + m->trays.bytes;
    out->ratio = 2.0 * (double)h->view_count * (double)m->range / (double)out->bytes;
}

COHSM_DEF cohsm_result cohsm_location(const cohsm_maps *m, uint32_t map, float out[4])
{
    cohsm__logger log = cohsm__logger_of_maps(m, "cohsm_location");

    if (!m) return COHSM_ERR_ARGUMENT;
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (map >= m->head.map_count) {
        cohsm__log_bound(&log, "map", map, "below", m->head.map_count, "the number of maps");
        return COHSM_ERR_ARGUMENT;
    }
    cohsm__v3_store(out, cohsm__cell_location(&m->head, m->locations, map));
    out[3] = m->head.positional ? 1.0f : 0.0f;
    return COHSM_OK;
}

/* Returns the place in the sequence of the map of a cell. */
static uint32_t cohsm__place_of_cell(const cohsm_maps *m, uint32_t x, uint32_t y, uint32_t z)
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
    cohsm__logger log = cohsm__logger_of_maps(m, "cohsm_depths");

    if (!m) return COHSM_ERR_ARGUMENT;
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (view >= m->head.view_count) {
        cohsm__log_bound(&log, "view", view, "below", m->head.view_count, "the number of views");
        return COHSM_ERR_ARGUMENT;
    }
    cohsm__cell_split(m->head.side, view % m->head.map_count, c);
    place = view / m->head.map_count * m->head.map_count + cohsm__place_of_cell(m, c[0], c[1], c[2]);
    for (p = 0; p < m->range; p++)
        out[p] = (uint16_t)cohsm__stored_depth(m, p, place);
    return COHSM_OK;
}

/* ==== src/csm/query.h ==== */

/* ---- query: which pixel of which map answers, and what it says ---- */

/* Samples are treated in tiles: first the map, the pixel and the depth of every sample are found; then the
   stored depths are searched in steps that each prefetch what the next step reads, so that cache misses
   overlap. */

enum {
    COHSM__TILE = 256,                  /* samples of a tile */
    COHSM__KEPT = 512                   /* slots for decoded depths: by 4 bits of x and 5 of y, for M = 128 */
};
#define COHSM__NO_PIXEL UINT32_MAX      /* the sample is outside the map or not finite, and so lit */

#if defined(__GNUC__) && !defined(__TINYC__)
#define COHSM__FLATTEN __attribute__((flatten))
#else
#define COHSM__FLATTEN
#endif

typedef struct cohsm__kept {            /* depths of one light that earlier samples decoded, by cohsm__slot */
    int32_t key[COHSM__KEPT], depth[COHSM__KEPT];
} cohsm__kept;

#ifndef COHSM_WITHOUT_SIMD
typedef struct cohsm__fractions {       /* of PCF: what the sixteen pixels of a sample have in common */
    float   weight[4][COHSM__TILE];     /* how far it lies towards the next cell or pixel, 0..1 */
    int16_t cell[2][COHSM__TILE], pixel[2][COHSM__TILE];    /* the lower one, perhaps one step outside */
    uint8_t valid[COHSM__TILE];         /* 0: no map answers */
} cohsm__fractions;
#endif

typedef struct cohsm__tile {            /* one object's samples, in its space */
    const cohsm_maps  *maps;
    const cohsm_query *query;
    uint32_t seed;                      /* of ROULETTE: each instance draws its own numbers, for else products
                                           would have another mean than those of PCF */
    size_t   count;
    cohsm_light_kind light_kind;        /* the query's; positions become directions on the way */
    int      one_light;                 /* not 0: light[.][0] is the light of all samples */
    float    point[3][COHSM__TILE];     /* in radii about the sphere's centre */
    float    light[3][COHSM__TILE];     /* a direction, a position in radii, or parameters */
    uint32_t cell[COHSM__TILE];         /* the cell that COHSM_LIGHT_INDEX names */
    size_t   id[COHSM__TILE];           /* the sample's number in the query */
    float    visible[COHSM__TILE];      /* the answers */
    uint32_t pixel[COHSM__TILE];        /* the pixel that the sample falls into, or COHSM__NO_PIXEL */
    uint32_t place[COHSM__TILE];        /* the place of its map in the sequence */
    int32_t  depth[COHSM__TILE];        /* the sample's depth, to be compared with the stored one */
    union {                             /* no tile needs both */
        cohsm__kept kept;               /* of NEAREST with one light */
#ifndef COHSM_WITHOUT_SIMD
        cohsm__fractions fractions;     /* of PCF */
#endif
    } work;
} cohsm__tile;

/* In a scene, samples are tested against the spheres of several instances at once, and ask those alone that
   their rays may meet. */
enum {
    COHSM__BLOCK = 2048,                /* samples that are tested at a time */
    COHSM__BUNCH = 16                   /* instances */
};
#define COHSM__SLACK 1e-5f              /* rounding of a transform, as a part of the coordinates */

/* What shadows lies inside the sphere, which is that of the maps in the world and somewhat larger. Maps
   answer with a direction that lies by up to an angle off the light's: `slope` is its tangent, `cone_radius`
   the radius over its cosine. */
typedef struct cohsm__sphere { float x, y, z, radius, cone_radius, slope; } cohsm__sphere;

typedef struct cohsm__bunch {
    uint32_t      count;
    cohsm__sphere sphere[COHSM__BUNCH];
    uint32_t      asked[COHSM__BUNCH][COHSM__BLOCK / 32];   /* a bit for each sample */
} cohsm__bunch;

static void cohsm__keep_nothing(cohsm__kept *kept)
{
    memset(kept->key, 0xff, sizeof kept->key);              /* -1 */
    memset(kept->depth, 0, sizeof kept->depth);
}

static void cohsm__tile_start(cohsm__tile *t, const cohsm_query *q, const cohsm_maps *maps, uint32_t instance)
{
    t->maps = maps;
    t->query = q;
    t->seed = q->seed + 0x9e3779b9u * instance;
    t->light_kind = q->light_kind;
    t->one_light = q->one_light;
    t->count = 0;
    if (q->one_light) cohsm__keep_nothing(&t->work.kept);
}

/* Writes the continuous position of a light in the domain, in units of cells, so that the centres of cells
   are whole numbers. */
static void cohsm__domain_position(const cohsm_maps *m, cohsm__v3 l, cohsm_light_kind kind, float f[3])
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

/* Brings a cell one step outside back: around the seam, over a pole, across the edge of the octahedral
   square, or to the border. */
static void cohsm__wrap_cell(const cohsm_maps *m, int *c)
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

/* A point as one map sees it: its position in pixels, its depth in 16 bits, and the face of the cube. */
typedef struct cohsm__projected { float x, y, depth; uint32_t face; } cohsm__projected;

static cohsm__projected cohsm__project_point(const cohsm_maps *m, uint32_t cell, cohsm__v3 p, float bias)
{
    float half = 0.5f * (float)m->head.map_side, w;
    cohsm__projected s;
    cohsm__axes f;
    cohsm__v3 q;

    s.face = 0;
    if (!m->head.positional) {
        f = cohsm__cell_axes(&m->head, m->locations, m->angles, cell);
        s.x = cohsm__v3_dot(p, f.right) * half + half;
        s.y = cohsm__v3_dot(p, f.up) * half + half;
        s.depth =
            (0.5f - 0.5f * cohsm__v3_dot(p, f.back) - bias / (float)m->head.map_side) * (float)COHSM__HIT_MAX;
        return s;
    }
    q = cohsm__v3_sub(cohsm__cell_location(&m->head, m->locations, cell), cohsm__v3_load(m->head.center));
    q = cohsm__v3_sub(p, cohsm__v3_scale(q, 1.0f / m->head.radius));
    s.face = cohsm__face_of(q);
    cohsm__face_coordinates(s.face, q, &s.x, &s.y, &w);
    s.x = s.x / w * half + half;
    s.y = s.y / w * half + half;
    s.depth = w * (1.0f - 2.0f * bias / (float)m->head.map_side) * (m->head.radius / m->head.depth_far) *
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
    float top = (float)m->head.map_side;
    uint32_t p;
    if (m->head.positional) {                       /* rounding may leave the face by a hair */
        x = x < 0.0f ? 0.0f : x >= top ? top - 0.5f : x;
        y = y < 0.0f ? 0.0f : y >= top ? top - 0.5f : y;
    }
    if (!(x >= 0.0f && x < top && y >= 0.0f && y < top)) return COHSM__NO_PIXEL;
    p = (uint32_t)y * m->head.map_side + (uint32_t)x;
    return p >= m->head.pixel_begin && p < m->head.pixel_end ? p - m->head.pixel_begin : COHSM__NO_PIXEL;
}

static float cohsm__lit_at(const cohsm_maps *m, uint32_t pixel, uint32_t place, int32_t depth)
{
    if (pixel == COHSM__NO_PIXEL || depth < 0) return 1.0f;
    return depth > (int32_t)cohsm__stored_depth(m, pixel, place) ? 0.0f : 1.0f;
}

/* Returns how dark four pixels of one map make a point. Weights of generalised PCF are products of one
   fraction for each of the d + 2 dimensions (paper 4.5). The dark part is summed, so that a sample which
   nothing shadows is exactly 1. */
static float cohsm__pcf_map(const cohsm_maps *m, const int *c, cohsm__v3 p, float bias)
{
    uint32_t place = cohsm__place_of_cell(m, (uint32_t)c[0], (uint32_t)c[1], (uint32_t)c[2]), corner;
    cohsm__projected s = cohsm__project_point(m, cohsm__cell_index(m, c), p, bias);
    float x, y, fx, fy;
    float dark = 0.0f;
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
        if (weight > 0.0f) dark += weight * (1.0f - cohsm__lit_at(m, pixel, place, depth));
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
        cohsm__wrap_cell(m, c);
        dark += weight * cohsm__pcf_map(m, c, p, bias);
    }
    return dark;
}

/* Returns the lit part; where all is dark, rounding of the weights may have left a little. */
static float cohsm__lit_from_dark(float dark) { return dark >= 0.999999f ? 0.0f : 1.0f - dark; }

static cohsm__v3 cohsm__tile_point(const cohsm__tile *t, size_t i)
{
    return cohsm__v3_make(t->point[0][i], t->point[1][i], t->point[2][i]);
}

static cohsm__v3 cohsm__tile_light(const cohsm__tile *t, size_t i)
{
    if (t->one_light) i = 0;
    return cohsm__v3_make(t->light[0][i], t->light[1][i], t->light[2][i]);
}

/* Returns a random number for ROULETTE and 0.5 for other filters. Roulette takes the nearest neighbour of a
   position moved at random by up to half a step: a fraction f is rounded up with probability f, which is its
   weight in PCF. */
static float cohsm__jitter(const cohsm__tile *t, uint32_t id, uint32_t dimension)
{
    return t->query->filter == COHSM_FILTER_ROULETTE ? cohsm__random(t->seed, id, dimension) : 0.5f;
}

/* Says whether a direction has a length that can be computed. */
static int cohsm__length_usable(cohsm__v3 l)
{
    float length = cohsm__v3_length(l);
    return length > 0.0f && length < 3.4e38f;
}

/* Finds map, pixel and depth of sample i; with PCF it finds the visibility at once. */
static void cohsm__address(cohsm__tile *t, size_t i)
{
    const cohsm_maps *m = t->maps;
    const cohsm_query *q = t->query;
    cohsm__v3 p = cohsm__tile_point(t, i), l = cohsm__tile_light(t, i);
    cohsm__projected s;
    float f[3] = { 0, 0, 0 };
    uint32_t k, id = (uint32_t)t->id[i];
    int c[3] = { 0, 0, 0 };

    if (!cohsm__v3_finite(p) || (t->light_kind != COHSM_LIGHT_INDEX && !cohsm__v3_finite(l))) return;
    if (t->light_kind == COHSM_LIGHT_INDEX) {
        if (t->cell[t->one_light ? 0 : i] >= m->head.map_count) return;     /* lit, as by a light at NaN */
        cohsm__cell_split(m->head.side, t->cell[t->one_light ? 0 : i], (uint32_t *)c);
        if (q->filter == COHSM_FILTER_PCF) {
            t->visible[i] = cohsm__lit_from_dark(cohsm__pcf_map(m, c, p, q->bias));
            return;
        }
    } else {
        if (t->light_kind != COHSM_LIGHT_PARAMETER && !cohsm__length_usable(l)) return;
        cohsm__domain_position(m, l, t->light_kind, f);
        if (q->filter == COHSM_FILTER_PCF) {
            t->visible[i] = cohsm__lit_from_dark(cohsm__pcf(m, f, p, q->bias));
            return;
        }
        for (k = 0; k < m->head.dimensions; k++) c[k] = cohsm__floor(f[k] + cohsm__jitter(t, id, k));
        cohsm__wrap_cell(m, c);
    }
    s = cohsm__project_point(m, cohsm__cell_index(m, c), p, q->bias);
    if (q->filter == COHSM_FILTER_ROULETTE) {
        s.x += cohsm__jitter(t, id, 3) - 0.5f;
        s.y += cohsm__jitter(t, id, 4) - 0.5f;
    }
    t->depth[i] = cohsm__compared_depth(s.depth);
    if (t->depth[i] < 0) return;
    t->pixel[i] = cohsm__pixel(m, s.x, s.y);
    t->place[i] =
        cohsm__place_of_cell(m, (uint32_t)c[0], (uint32_t)c[1], (uint32_t)c[2]) + s.face * m->head.map_count;
}

/* The search for the stored depth of one of the tile's samples: `at` points to its list first, then to its
   block, and view counts from there. */
typedef struct cohsm__found { const uint32_t *at; uint32_t view, sample; } cohsm__found;

/* Says whether a semi-local light must be refused, since it is inside the hull. */
static int cohsm__light_refused(const cohsm_maps *m, cohsm__v3 l)
{
    int i;
    for (i = 0; i < COHSM__DOP_AXES; i++) {
        float d = cohsm__v3_dot(cohsm__dop_axis(i), l);
        if (d < m->dop[2 * i] || d > m->dop[2 * i + 1]) return 0;
    }
    return 1;
}

/* Says whether the object may stand between a point and a semi-local light outside the hull, which is so if
   the segment between them meets the hull. Beyond the light the ray may meet the hull as well (T67); but the
   maps, which know directions only, must not be asked then. */
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
        if (enter > leave) return 0;
    }
    return 1;
}

/* ==== src/csm/query_directions.h ==== */

/* ---- query: directions to latitude-longitude maps, in steps ---- */

/* Samples whose lights are directions, and whose maps are LATLONG, are treated a step of 64 at a time. The
   result is that of cohsm__address, but comes from loops of constant length without branches or calls, which
   compilers vectorise at -O2 for every instruction set (kernels_directions.h). A step is so small that what
   one loop writes or prefetches is still in the first-level cache for the next loop. */

enum { COHSM__STEP = 64 };

typedef struct cohsm__step {
    float jitter[5][COHSM__STEP];       /* of the cell's two dimensions, [2] unused, and of the pixel's two */
    float at[4][COHSM__STEP];           /* jittered position: [0] and [1] in the domain, in cells; [2] and [3]
                                           in the map, in pixels */
    float depth[COHSM__STEP];           /* in 16 bits, less the bias */
    int32_t cell[2][COHSM__STEP], valid[COHSM__STEP];
    float angle[4][COHSM__STEP];        /* cos phi, sin phi, cos theta, sin theta */
    float right[3][COHSM__STEP], up[3][COHSM__STEP], back[3][COHSM__STEP];
} cohsm__step;

/* Finds the cell of the map that answers for one light. Returns 0 if there is none, so that every point is
   lit. */
static int cohsm__cell_of_light(const cohsm_maps *m, cohsm_light_kind kind, cohsm__v3 l, uint32_t index,
                                uint32_t *cell)
{
    int c[3] = { 0, 0, 0 }, k;
    float f[3];

    *cell = index;
    if (kind == COHSM_LIGHT_INDEX) return index < m->head.map_count;
    if (!cohsm__v3_finite(l) || (kind != COHSM_LIGHT_PARAMETER && !cohsm__length_usable(l))) return 0;
    cohsm__domain_position(m, l, kind, f);
    for (k = 0; k < (int)m->head.dimensions; k++) c[k] = cohsm__floor(f[k] + 0.5f);
    cohsm__wrap_cell(m, c);
    *cell = cohsm__cell_index(m, c);
    return 1;
}

/* A point's key says in which pixel of which map it falls: the pixel's number within the shard and, above
   COHSM__KEY_BITS, the face of a cube map. */
enum { COHSM__KEY_BITS = 20 };          /* M is at most 1024 */

/* Returns where the decoded depth of a key is kept: by the low bits of x and y, since neighbouring points
   share pixels. */
static uint32_t cohsm__slot(uint32_t key) { return (key & 15u) | (key >> 3 & 0x1f0u); }

enum {
    COHSM__STREAM = 1024,               /* the most points of a stream */
    COHSM__AHEAD = 3072                 /* bytes of points that are prefetched before they are wanted */
};

typedef struct cohsm__stream {          /* points that have one light */
    const cohsm_maps *maps;
    cohsm__axes axes;                   /* of maps of directions */
    cohsm__v3 eye;                      /* of cube maps, in radii about the centre */
    uint32_t place;                     /* of the map; of a cube map, that of its first face */
    float    bias;                      /* the query's */
    size_t   count;
    const char *points;                 /* as they stand in the query, `stride` bytes apart; NULL: x, y, z
                                           have them, in radii about the centre */
    size_t   stride;
    const float *x, *y, *z;
    cohsm__kept *kept;
    /* The caller's room for as many numbers as there are points. */
    int32_t  *key;                      /* of each point, or -1 if it falls into no pixel */
    int32_t  *depth;                    /* of each point, to be compared */
    uint32_t *list;                     /* keys whose depths are to be decoded */
    uint32_t listed;
} cohsm__stream;

/* Makes a stream for the map of a cell, which is still without points. */
static void cohsm__stream_make(cohsm__stream *s, const cohsm_maps *m, uint32_t cell, float bias,
                               cohsm__kept *kept)
{
    uint32_t c[3];

    memset(s, 0, sizeof *s);
    cohsm__cell_split(m->head.side, cell, c);
    s->maps = m;
    s->place = cohsm__place_of_cell(m, c[0], c[1], c[2]);
    s->bias = bias;
    s->kept = kept;
    if (m->head.positional) {
        s->eye = cohsm__v3_sub(cohsm__cell_location(&m->head, m->locations, cell),
                               cohsm__v3_load(m->head.center));
        s->eye = cohsm__v3_scale(s->eye, 1.0f / m->head.radius);
    } else s->axes = cohsm__cell_axes(&m->head, m->locations, m->angles, cell);
}

/* ==== src/csm/kernels_begin.h ==== */

/* ---- kernels: one text, compiled for every instruction set ---- */

static const int32_t cohsm__numbers[16] = { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15 };

/* Names that every instruction set has of its own, see unit simd. */
#define cohsm__triangles COHSM__NAME_IN_SET(cohsm__triangles, COHSM__SET)
#define cohsm__spans COHSM__NAME_IN_SET(cohsm__spans, COHSM__SET)
#define cohsm__sides COHSM__NAME_IN_SET(cohsm__sides, COHSM__SET)
#define cohsm__span COHSM__NAME_IN_SET(cohsm__span, COHSM__SET)
#define cohsm__span_clamp COHSM__NAME_IN_SET(cohsm__span_clamp, COHSM__SET)
#define cohsm__span_meets COHSM__NAME_IN_SET(cohsm__span_meets, COHSM__SET)
#define cohsm__spans_of COHSM__NAME_IN_SET(cohsm__spans_of, COHSM__SET)
#define cohsm__enter_hits COHSM__NAME_IN_SET(cohsm__enter_hits, COHSM__SET)
#define cohsm__note_hits COHSM__NAME_IN_SET(cohsm__note_hits, COHSM__SET)
#define cohsm__side_from COHSM__NAME_IN_SET(cohsm__side_from, COHSM__SET)
#define cohsm__side_loses COHSM__NAME_IN_SET(cohsm__side_loses, COHSM__SET)
#define cohsm__sides_step COHSM__NAME_IN_SET(cohsm__sides_step, COHSM__SET)
#define cohsm__side_areas COHSM__NAME_IN_SET(cohsm__side_areas, COHSM__SET)
#define cohsm__to_front COHSM__NAME_IN_SET(cohsm__to_front, COHSM__SET)
#define cohsm__draw_boxes COHSM__NAME_IN_SET(cohsm__draw_boxes, COHSM__SET)
#define cohsm__draw_alone COHSM__NAME_IN_SET(cohsm__draw_alone, COHSM__SET)
#define cohsm__draw_some COHSM__NAME_IN_SET(cohsm__draw_some, COHSM__SET)
#define cohsm__draw_specks COHSM__NAME_IN_SET(cohsm__draw_specks, COHSM__SET)
#define cohsm__draw_queue COHSM__NAME_IN_SET(cohsm__draw_queue, COHSM__SET)
#define cohsm__sample_middle COHSM__NAME_IN_SET(cohsm__sample_middle, COHSM__SET)
#define cohsm__corner_load COHSM__NAME_IN_SET(cohsm__corner_load, COHSM__SET)
#define cohsm__fixed COHSM__NAME_IN_SET(cohsm__fixed, COHSM__SET)
#define cohsm__depths COHSM__NAME_IN_SET(cohsm__depths, COHSM__SET)
#define cohsm__queue_add COHSM__NAME_IN_SET(cohsm__queue_add, COHSM__SET)
#define cohsm__image_axes COHSM__NAME_IN_SET(cohsm__image_axes, COHSM__SET)
#define cohsm__image_axes_of COHSM__NAME_IN_SET(cohsm__image_axes_of, COHSM__SET)
#define cohsm__prefetch_part COHSM__NAME_IN_SET(cohsm__prefetch_part, COHSM__SET)
#define cohsm__slab_corner COHSM__NAME_IN_SET(cohsm__slab_corner, COHSM__SET)
#define cohsm__slab_add COHSM__NAME_IN_SET(cohsm__slab_add, COHSM__SET)
#define cohsm__find_slab COHSM__NAME_IN_SET(cohsm__find_slab, COHSM__SET)
#define cohsm__specks_add COHSM__NAME_IN_SET(cohsm__specks_add, COHSM__SET)
#define cohsm__slab_load COHSM__NAME_IN_SET(cohsm__slab_load, COHSM__SET)
#define cohsm__enqueue_some COHSM__NAME_IN_SET(cohsm__enqueue_some, COHSM__SET)
#define cohsm__enqueue_slab COHSM__NAME_IN_SET(cohsm__enqueue_slab, COHSM__SET)
#define cohsm__divide_65535 COHSM__NAME_IN_SET(cohsm__divide_65535, COHSM__SET)
#define cohsm__grid_above_lanes COHSM__NAME_IN_SET(cohsm__grid_above_lanes, COHSM__SET)
#define cohsm__grid_below_lanes COHSM__NAME_IN_SET(cohsm__grid_below_lanes, COHSM__SET)
#define cohsm__intervals COHSM__NAME_IN_SET(cohsm__intervals, COHSM__SET)
#define cohsm__intervals_of COHSM__NAME_IN_SET(cohsm__intervals_of, COHSM__SET)
#define cohsm__narrow COHSM__NAME_IN_SET(cohsm__narrow, COHSM__SET)
#define cohsm__sees8 COHSM__NAME_IN_SET(cohsm__sees8, COHSM__SET)
#define cohsm__append8 COHSM__NAME_IN_SET(cohsm__append8, COHSM__SET)
#define cohsm__find_clusters COHSM__NAME_IN_SET(cohsm__find_clusters, COHSM__SET)
#define cohsm__find_block COHSM__NAME_IN_SET(cohsm__find_block, COHSM__SET)
#define cohsm__found_depth COHSM__NAME_IN_SET(cohsm__found_depth, COHSM__SET)
#define cohsm__tray_depths COHSM__NAME_IN_SET(cohsm__tray_depths, COHSM__SET)
#define cohsm__find_depths COHSM__NAME_IN_SET(cohsm__find_depths, COHSM__SET)
#define cohsm__search_tile COHSM__NAME_IN_SET(cohsm__search_tile, COHSM__SET)
#define cohsm__load_vectors COHSM__NAME_IN_SET(cohsm__load_vectors, COHSM__SET)
#define cohsm__step_roots COHSM__NAME_IN_SET(cohsm__step_roots, COHSM__SET)
#define cohsm__step_lights COHSM__NAME_IN_SET(cohsm__step_lights, COHSM__SET)
#define cohsm__step_wrap COHSM__NAME_IN_SET(cohsm__step_wrap, COHSM__SET)
#define cohsm__step_axes COHSM__NAME_IN_SET(cohsm__step_axes, COHSM__SET)
#define cohsm__step_project COHSM__NAME_IN_SET(cohsm__step_project, COHSM__SET)
#define cohsm__step_pixels COHSM__NAME_IN_SET(cohsm__step_pixels, COHSM__SET)
#define cohsm__step_places COHSM__NAME_IN_SET(cohsm__step_places, COHSM__SET)
#define cohsm__step_jitter COHSM__NAME_IN_SET(cohsm__step_jitter, COHSM__SET)
#define cohsm__step_fractions COHSM__NAME_IN_SET(cohsm__step_fractions, COHSM__SET)
#define cohsm__address_latlong COHSM__NAME_IN_SET(cohsm__address_latlong, COHSM__SET)
#define cohsm__cells_latlong COHSM__NAME_IN_SET(cohsm__cells_latlong, COHSM__SET)
#define cohsm__project_latlong COHSM__NAME_IN_SET(cohsm__project_latlong, COHSM__SET)
#define cohsm__corner_latlong COHSM__NAME_IN_SET(cohsm__corner_latlong, COHSM__SET)
#define cohsm__views COHSM__NAME_IN_SET(cohsm__views, COHSM__SET)
#define cohsm__views_of COHSM__NAME_IN_SET(cohsm__views_of, COHSM__SET)
#define cohsm__seen COHSM__NAME_IN_SET(cohsm__seen, COHSM__SET)
#define cohsm__see_along_axes COHSM__NAME_IN_SET(cohsm__see_along_axes, COHSM__SET)
#define cohsm__see_on_face COHSM__NAME_IN_SET(cohsm__see_on_face, COHSM__SET)
#define cohsm__onto_face COHSM__NAME_IN_SET(cohsm__onto_face, COHSM__SET)
#define cohsm__keys_decode COHSM__NAME_IN_SET(cohsm__keys_decode, COHSM__SET)
#define cohsm__stream_load COHSM__NAME_IN_SET(cohsm__stream_load, COHSM__SET)
#define cohsm__stream_project COHSM__NAME_IN_SET(cohsm__stream_project, COHSM__SET)
#define cohsm__load_strided COHSM__NAME_IN_SET(cohsm__load_strided, COHSM__SET)
#define cohsm__rays COHSM__NAME_IN_SET(cohsm__rays, COHSM__SET)
#define cohsm__load_rays COHSM__NAME_IN_SET(cohsm__load_rays, COHSM__SET)
#define cohsm__segments_miss COHSM__NAME_IN_SET(cohsm__segments_miss, COHSM__SET)
#define cohsm__cones_miss COHSM__NAME_IN_SET(cohsm__cones_miss, COHSM__SET)
#define cohsm__meet_spheres COHSM__NAME_IN_SET(cohsm__meet_spheres, COHSM__SET)
#define cohsm__slots COHSM__NAME_IN_SET(cohsm__slots, COHSM__SET)
#define cohsm__stream_find COHSM__NAME_IN_SET(cohsm__stream_find, COHSM__SET)
#define cohsm__stream_decode COHSM__NAME_IN_SET(cohsm__stream_decode, COHSM__SET)
#define cohsm__stream_rest COHSM__NAME_IN_SET(cohsm__stream_rest, COHSM__SET)
#define cohsm__stream_compare COHSM__NAME_IN_SET(cohsm__stream_compare, COHSM__SET)
#define cohsm__one_light COHSM__NAME_IN_SET(cohsm__one_light, COHSM__SET)
#define COHSM__ALL_LANES ((1u << COHSM__LANE_COUNT) - 1u)       /* bits of a mask in which all lanes are */

#define COHSM__SET plain
#define COHSM__WIDTH COHSM__SIMD_WIDTH
#define COHSM__LANE_COUNT 8

#endif /* !CSM_IMPLEMENTED */

#ifdef COHSM__SET
#if COHSM_VERSION != 10000 /* this file's: another one that includes it as COHSM_FILE has its own */
#error "csm.h: the file that COHSM_FILE names is of another version than the one that includes it"
#endif

/* ==== src/shared/simd_begin.h ==== */

/* unit simd_begin, needs simd: what the kernels of one instruction set are compiled with */

#undef COHSM__KERNEL
#undef COHSM__IN_KERNEL
#undef COHSM__IN_LARGE_KERNEL
#undef COHSM__INTEL
#undef COHSM__EACH

#if COHSM__WIDTH == 16
#define COHSM__KERNEL COHSM__TARGET_AVX512
#elif COHSM__WIDTH == 8
#define COHSM__KERNEL COHSM__TARGET_AVX2
#else
#define COHSM__KERNEL
#endif

#if COHSM__WIDTH == 16
#define COHSM__INTEL(name) _mm512_##name
#elif COHSM__WIDTH == 8
#define COHSM__INTEL(name) _mm256_##name
#else
#define COHSM__INTEL(name) _mm_##name
#endif

/* COHSM__IN_LARGE_KERNEL stands after `static`, before a function that a kernel calls dozens of times. Such a
   function is not inlined without optimisation, nor with gcc's sanitizers, which take minutes to build large
   functions. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define COHSM__IN_KERNEL __attribute__((always_inline)) COHSM__KERNEL
#else
#define COHSM__IN_KERNEL COHSM__KERNEL
#endif
#if defined(__GNUC__) && !defined(__TINYC__) && (!defined(__OPTIMIZE__) || defined(__SANITIZE_ADDRESS__))
#define COHSM__IN_LARGE_KERNEL __attribute__((noinline)) COHSM__KERNEL
#else
#define COHSM__IN_LARGE_KERNEL inline COHSM__IN_KERNEL
#endif

/* COHSM__EACH executes statements for every piece of COHSM__WIDTH lanes. The number of the piece is a constant in
   them, so that compilers keep pieces in registers. */
#if COHSM__WIDTH > 1 && COHSM__LANE_COUNT == COHSM__WIDTH
#define COHSM__EACH(...) { enum { piece = 0 }; __VA_ARGS__; }
#elif COHSM__WIDTH > 1 && COHSM__LANE_COUNT == 2 * COHSM__WIDTH
#define COHSM__EACH(...) { enum { piece = 0 }; __VA_ARGS__; } { enum { piece = 1 }; __VA_ARGS__; }
#elif COHSM__WIDTH > 1 && COHSM__LANE_COUNT == 4 * COHSM__WIDTH
#define COHSM__EACH(...) \
    { enum { piece = 0 }; __VA_ARGS__; } { enum { piece = 1 }; __VA_ARGS__; } \
    { enum { piece = 2 }; __VA_ARGS__; } { enum { piece = 3 }; __VA_ARGS__; }
#else
#define COHSM__EACH(...) \
    { int piece; for (piece = 0; piece < COHSM__LANE_COUNT / COHSM__WIDTH; piece++) { __VA_ARGS__; } }
#endif

/* ==== src/shared/simd_x86.h ==== */

/* unit simd_x86, needs simd_begin: lanes of SSE2, AVX2 and AVX-512 */

#if COHSM__SIMD_X86 || COHSM__WIDTH > 4

#if COHSM__WIDTH == 16
typedef struct cohsm__lanes { __m512 v[COHSM__LANE_COUNT / 16]; } cohsm__lanes;
typedef struct cohsm__lane_ints { __m512i v[COHSM__LANE_COUNT / 16]; } cohsm__lane_ints;
typedef struct cohsm__lane_mask { __mmask16 v[COHSM__LANE_COUNT / 16]; } cohsm__lane_mask;
#elif COHSM__WIDTH == 8
typedef struct cohsm__lanes { __m256 v[COHSM__LANE_COUNT / 8]; } cohsm__lanes;
typedef struct cohsm__lane_ints { __m256i v[COHSM__LANE_COUNT / 8]; } cohsm__lane_ints;
typedef struct cohsm__lane_mask { __m256 v[COHSM__LANE_COUNT / 8]; } cohsm__lane_mask;
#else
typedef struct cohsm__lanes { __m128 v[COHSM__LANE_COUNT / 4]; } cohsm__lanes;
typedef struct cohsm__lane_ints { __m128i v[COHSM__LANE_COUNT / 4]; } cohsm__lane_ints;
typedef struct cohsm__lane_mask { __m128 v[COHSM__LANE_COUNT / 4]; } cohsm__lane_mask;
#endif

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_load(const float *from)
{
    cohsm__lanes a;
    COHSM__EACH(a.v[piece] = COHSM__INTEL(loadu_ps)(from + piece * COHSM__WIDTH))
    return a;
}

static inline COHSM__IN_KERNEL void cohsm__lanes_store(float *to, cohsm__lanes a)
{
    COHSM__EACH(COHSM__INTEL(storeu_ps)(to + piece * COHSM__WIDTH, a.v[piece]))
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_all(float x)
{
    cohsm__lanes a;
    COHSM__EACH(a.v[piece] = COHSM__INTEL(set1_ps)(x))
    return a;
}

/* Comparisons with what is not a number are false, but for differ, which is true. */
static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__lanes_greater(cohsm__lanes a, cohsm__lanes b)
{
    cohsm__lane_mask m;
#if COHSM__WIDTH == 16
    COHSM__EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_GT_OQ))
#elif COHSM__WIDTH == 8
    COHSM__EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_GT_OQ))
#else
    COHSM__EACH(m.v[piece] = _mm_cmpgt_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__lanes_at_least(cohsm__lanes a, cohsm__lanes b)
{
    cohsm__lane_mask m;
#if COHSM__WIDTH == 16
    COHSM__EACH(m.v[piece] = _mm512_cmp_ps_mask(a.v[piece], b.v[piece], _CMP_GE_OQ))
#elif COHSM__WIDTH == 8
    COHSM__EACH(m.v[piece] = _mm256_cmp_ps(a.v[piece], b.v[piece], _CMP_GE_OQ))
#else
    COHSM__EACH(m.v[piece] = _mm_cmpge_ps(a.v[piece], b.v[piece]))
#endif
    return m;
}

/* Returns m ? a : b in each lane. */
static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_select(cohsm__lane_mask m, cohsm__lanes a,
                                                 cohsm__lanes b)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(a.v[piece] = _mm512_mask_mov_ps(b.v[piece], m.v[piece], a.v[piece]))
#elif COHSM__WIDTH == 8
    COHSM__EACH(a.v[piece] = _mm256_blendv_ps(b.v[piece], a.v[piece], m.v[piece]))
#else
    COHSM__EACH(a.v[piece] = _mm_or_ps(_mm_and_ps(m.v[piece], a.v[piece]), _mm_andnot_ps(m.v[piece], b.v[piece])))
#endif
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_add(cohsm__lanes a, cohsm__lanes b)
{
    COHSM__EACH(a.v[piece] = COHSM__INTEL(add_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_sub(cohsm__lanes a, cohsm__lanes b)
{
    COHSM__EACH(a.v[piece] = COHSM__INTEL(sub_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_mul(cohsm__lanes a, cohsm__lanes b)
{
    COHSM__EACH(a.v[piece] = COHSM__INTEL(mul_ps)(a.v[piece], b.v[piece]))
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_div(cohsm__lanes a, cohsm__lanes b)
{
    COHSM__EACH(a.v[piece] = COHSM__INTEL(div_ps)(a.v[piece], b.v[piece]))
    return a;
}

/* Returns a b + c. */
static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_muladd(cohsm__lanes a, cohsm__lanes b, cohsm__lanes c)
{
#if COHSM__WIDTH > 4
    COHSM__EACH(a.v[piece] = COHSM__INTEL(fmadd_ps)(a.v[piece], b.v[piece], c.v[piece]))
#else
    COHSM__EACH(a.v[piece] = _mm_add_ps(_mm_mul_ps(a.v[piece], b.v[piece]), c.v[piece]))
#endif
    return a;
}

/* Returns a > b ? a : b, so that b is the answer if one is not a number. */
static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_max(cohsm__lanes a, cohsm__lanes b)
{
#if COHSM__WIDTH == 16                           /* gcc 12 warns of what max without a mask calls */
    COHSM__EACH(a.v[piece] = _mm512_maskz_max_ps((__mmask16)0xffff, a.v[piece], b.v[piece]))
#else
    COHSM__EACH(a.v[piece] = COHSM__INTEL(max_ps)(a.v[piece], b.v[piece]))
#endif
    return a;
}

/* Returns a < b ? a : b. */
static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_min(cohsm__lanes a, cohsm__lanes b)
{
#if COHSM__WIDTH == 16                           /* gcc 12 warns of what min without a mask calls */
    COHSM__EACH(a.v[piece] = _mm512_maskz_min_ps((__mmask16)0xffff, a.v[piece], b.v[piece]))
#else
    COHSM__EACH(a.v[piece] = COHSM__INTEL(min_ps)(a.v[piece], b.v[piece]))
#endif
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_sqrt(cohsm__lanes a)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(a.v[piece] = _mm512_maskz_sqrt_ps((__mmask16)0xffff, a.v[piece]))
#else
    COHSM__EACH(a.v[piece] = COHSM__INTEL(sqrt_ps)(a.v[piece]))
#endif
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_abs(cohsm__lanes a)
{
    COHSM__EACH(a.v[piece] = COHSM__INTEL(andnot_ps)(COHSM__INTEL(set1_ps)(-0.0f), a.v[piece]))
    return a;
}

/* Returns m ? a : 0. */
static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_keep(cohsm__lane_mask m, cohsm__lanes a)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(a.v[piece] = _mm512_maskz_mov_ps(m.v[piece], a.v[piece]))
#else
    COHSM__EACH(a.v[piece] = COHSM__INTEL(and_ps)(m.v[piece], a.v[piece]))
#endif
    return a;
}

/* Rounds towards 0. An int32_t must be able to hold each float. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__lanes_truncate(cohsm__lanes a)
{
    cohsm__lane_ints k;
#if COHSM__WIDTH == 16
    COHSM__EACH(k.v[piece] = _mm512_maskz_cvttps_epi32((__mmask16)0xffff, a.v[piece]))
#else
    COHSM__EACH(k.v[piece] = COHSM__INTEL(cvttps_epi32)(a.v[piece]))
#endif
    return k;
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_of_ints(cohsm__lane_ints k)
{
    cohsm__lanes a;
#if COHSM__WIDTH == 16
    COHSM__EACH(a.v[piece] = _mm512_maskz_cvtepi32_ps((__mmask16)0xffff, k.v[piece]))
#else
    COHSM__EACH(a.v[piece] = COHSM__INTEL(cvtepi32_ps)(k.v[piece]))
#endif
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__mask_and(cohsm__lane_mask m, cohsm__lane_mask n)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(m.v[piece] = (__mmask16)(m.v[piece] & n.v[piece]))
#else
    COHSM__EACH(m.v[piece] = COHSM__INTEL(and_ps)(m.v[piece], n.v[piece]))
#endif
    return m;
}

static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__mask_or(cohsm__lane_mask m, cohsm__lane_mask n)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(m.v[piece] = (__mmask16)(m.v[piece] | n.v[piece]))
#else
    COHSM__EACH(m.v[piece] = COHSM__INTEL(or_ps)(m.v[piece], n.v[piece]))
#endif
    return m;
}

/* Returns the mask as bits: bit l is that of lane l. */
static inline COHSM__IN_KERNEL uint32_t cohsm__mask_bits(cohsm__lane_mask m)
{
    uint32_t bits = 0;
#if COHSM__WIDTH == 16
    COHSM__EACH(bits |= (uint32_t)m.v[piece] << piece * COHSM__WIDTH)
#else
    COHSM__EACH(bits |= (uint32_t)COHSM__INTEL(movemask_ps)(m.v[piece]) << piece * COHSM__WIDTH)
#endif
    return bits;
}

static inline COHSM__IN_KERNEL int cohsm__mask_any(cohsm__lane_mask m)
{
    int any = 0;
#if COHSM__WIDTH == 16
    COHSM__EACH(any |= m.v[piece])
#else
    COHSM__EACH(any |= COHSM__INTEL(movemask_ps)(m.v[piece]))
#endif
    return any != 0;
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_load(const int32_t *from)
{
    cohsm__lane_ints k;
#if COHSM__WIDTH == 16
    COHSM__EACH(k.v[piece] = _mm512_loadu_si512((const void *)(from + piece * COHSM__WIDTH)))
#elif COHSM__WIDTH == 8
    COHSM__EACH(k.v[piece] = _mm256_loadu_si256((const __m256i *)(const void *)(from + piece * COHSM__WIDTH)))
#else
    COHSM__EACH(k.v[piece] = _mm_loadu_si128((const __m128i *)(const void *)(from + piece * COHSM__WIDTH)))
#endif
    return k;
}

static inline COHSM__IN_KERNEL void cohsm__ints_store(int32_t *to, cohsm__lane_ints k)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(_mm512_storeu_si512((void *)(to + piece * COHSM__WIDTH), k.v[piece]))
#elif COHSM__WIDTH == 8
    COHSM__EACH(_mm256_storeu_si256((__m256i *)(void *)(to + piece * COHSM__WIDTH), k.v[piece]))
#else
    COHSM__EACH(_mm_storeu_si128((__m128i *)(void *)(to + piece * COHSM__WIDTH), k.v[piece]))
#endif
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_all(int32_t x)
{
    cohsm__lane_ints k;
    COHSM__EACH(k.v[piece] = COHSM__INTEL(set1_epi32)(x))
    return k;
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_add(cohsm__lane_ints k, cohsm__lane_ints n)
{
    COHSM__EACH(k.v[piece] = COHSM__INTEL(add_epi32)(k.v[piece], n.v[piece]))
    return k;
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_sub(cohsm__lane_ints k, cohsm__lane_ints n)
{
    COHSM__EACH(k.v[piece] = COHSM__INTEL(sub_epi32)(k.v[piece], n.v[piece]))
    return k;
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_or(cohsm__lane_ints k, cohsm__lane_ints n)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(k.v[piece] = _mm512_or_si512(k.v[piece], n.v[piece]))
#elif COHSM__WIDTH == 8
    COHSM__EACH(k.v[piece] = _mm256_or_si256(k.v[piece], n.v[piece]))
#else
    COHSM__EACH(k.v[piece] = _mm_or_si128(k.v[piece], n.v[piece]))
#endif
    return k;
}

/* Returns m ? k : 0. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_keep(cohsm__lane_mask m, cohsm__lane_ints k)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(k.v[piece] = _mm512_maskz_mov_epi32(m.v[piece], k.v[piece]))
#elif COHSM__WIDTH == 8
    COHSM__EACH(k.v[piece] = _mm256_and_si256(_mm256_castps_si256(m.v[piece]), k.v[piece]))
#else
    COHSM__EACH(k.v[piece] = _mm_and_si128(_mm_castps_si128(m.v[piece]), k.v[piece]))
#endif
    return k;
}

static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__ints_equal(cohsm__lane_ints k, cohsm__lane_ints n)
{
    cohsm__lane_mask m;
#if COHSM__WIDTH == 16
    COHSM__EACH(m.v[piece] = _mm512_cmpeq_epi32_mask(k.v[piece], n.v[piece]))
#elif COHSM__WIDTH == 8
    COHSM__EACH(m.v[piece] = _mm256_castsi256_ps(_mm256_cmpeq_epi32(k.v[piece], n.v[piece])))
#else
    COHSM__EACH(m.v[piece] = _mm_castsi128_ps(_mm_cmpeq_epi32(k.v[piece], n.v[piece])))
#endif
    return m;
}

#endif

/* ==== src/shared/simd_plain.h ==== */

/* unit simd_plain, needs simd_begin: lanes of NEON, WebAssembly and others, or floats one by one */

#if !COHSM__SIMD_X86 && COHSM__WIDTH <= 4

#if COHSM__SIMD_VECTORS
typedef float cohsm__piece __attribute__((vector_size(16)));
typedef int32_t cohsm__piece_ints __attribute__((vector_size(16)));
typedef uint32_t cohsm__piece_words __attribute__((vector_size(16)));
#else
typedef float cohsm__piece;
typedef int32_t cohsm__piece_ints;
typedef uint32_t cohsm__piece_words;
#endif
typedef struct cohsm__lanes { cohsm__piece v[COHSM__LANE_COUNT / COHSM__WIDTH]; } cohsm__lanes;
typedef struct cohsm__lane_ints { cohsm__piece_ints v[COHSM__LANE_COUNT / COHSM__WIDTH]; } cohsm__lane_ints;
/* Lanes of 0 or -1. */
typedef struct cohsm__lane_mask { cohsm__piece_ints v[COHSM__LANE_COUNT / COHSM__WIDTH]; } cohsm__lane_mask;

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_load(const float *from)
{
    cohsm__lanes a;
    COHSM__EACH(memcpy(&a.v[piece], from + piece * COHSM__WIDTH, sizeof a.v[piece]))
    return a;
}

static inline COHSM__IN_KERNEL void cohsm__lanes_store(float *to, cohsm__lanes a)
{
    COHSM__EACH(memcpy(to + piece * COHSM__WIDTH, &a.v[piece], sizeof a.v[piece]))
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_all(float x)
{
    cohsm__lanes a;
#if COHSM__SIMD_VECTORS
    const cohsm__piece all = { x, x, x, x };
    COHSM__EACH(a.v[piece] = all)
#else
    COHSM__EACH(a.v[piece] = x)
#endif
    return a;
}

/* Comparisons with what is not a number are false, but for differ, which is true. */
static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__lanes_greater(cohsm__lanes a, cohsm__lanes b)
{
    cohsm__lane_mask m;
#if COHSM__SIMD_VECTORS
    COHSM__EACH(m.v[piece] = a.v[piece] > b.v[piece])
#else
    COHSM__EACH(m.v[piece] = -(a.v[piece] > b.v[piece]))
#endif
    return m;
}

static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__lanes_at_least(cohsm__lanes a, cohsm__lanes b)
{
    cohsm__lane_mask m;
#if COHSM__SIMD_VECTORS
    COHSM__EACH(m.v[piece] = a.v[piece] >= b.v[piece])
#else
    COHSM__EACH(m.v[piece] = -(a.v[piece] >= b.v[piece]))
#endif
    return m;
}

/* Returns m ? a : b in each lane. */
static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_select(cohsm__lane_mask m, cohsm__lanes a,
                                                 cohsm__lanes b)
{
#if COHSM__SIMD_VECTORS
    COHSM__EACH(a.v[piece] = (cohsm__piece)((m.v[piece] & (cohsm__piece_ints)a.v[piece]) |
                                  (~m.v[piece] & (cohsm__piece_ints)b.v[piece])))
#else
    COHSM__EACH(a.v[piece] = m.v[piece] ? a.v[piece] : b.v[piece])
#endif
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_add(cohsm__lanes a, cohsm__lanes b)
{
    COHSM__EACH(a.v[piece] = a.v[piece] + b.v[piece])
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_sub(cohsm__lanes a, cohsm__lanes b)
{
    COHSM__EACH(a.v[piece] = a.v[piece] - b.v[piece])
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_mul(cohsm__lanes a, cohsm__lanes b)
{
    COHSM__EACH(a.v[piece] = a.v[piece] * b.v[piece])
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_div(cohsm__lanes a, cohsm__lanes b)
{
    COHSM__EACH(a.v[piece] = a.v[piece] / b.v[piece])
    return a;
}

/* Returns a b + c. */
static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_muladd(cohsm__lanes a, cohsm__lanes b, cohsm__lanes c)
{
    COHSM__EACH(a.v[piece] = a.v[piece] * b.v[piece] + c.v[piece])
    return a;
}

/* Returns a > b ? a : b, so that b is the answer if one is not a number. */
static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_max(cohsm__lanes a, cohsm__lanes b)
{
    return cohsm__lanes_select(cohsm__lanes_greater(a, b), a, b);
}

/* Returns a < b ? a : b. */
static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_min(cohsm__lanes a, cohsm__lanes b)
{
    return cohsm__lanes_select(cohsm__lanes_greater(b, a), a, b);
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_sqrt(cohsm__lanes a)
{
#if COHSM__SIMD_VECTORS
#if defined(__aarch64__) && !defined(COHSM__NO_SIMD)
    COHSM__EACH(a.v[piece] = (cohsm__piece)vsqrtq_f32((float32x4_t)a.v[piece]))
#elif defined(__wasm_simd128__) && !defined(COHSM__NO_SIMD)
    COHSM__EACH(a.v[piece] = (cohsm__piece)wasm_f32x4_sqrt((v128_t)a.v[piece]))
#else
    int k;
    COHSM__EACH(for (k = 0; k < 4; k++) a.v[piece][k] = sqrtf(a.v[piece][k]))
#endif
#else
    COHSM__EACH(a.v[piece] = sqrtf(a.v[piece]))
#endif
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_abs(cohsm__lanes a)
{
#if COHSM__SIMD_VECTORS
    const int32_t b = 0x7fffffff;
    const cohsm__piece_ints bits = { b, b, b, b };
    COHSM__EACH(a.v[piece] = (cohsm__piece)((cohsm__piece_ints)a.v[piece] & bits))
#else
    COHSM__EACH(a.v[piece] = fabsf(a.v[piece]))
#endif
    return a;
}

/* Returns m ? a : 0. */
static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_keep(cohsm__lane_mask m, cohsm__lanes a)
{
#if COHSM__SIMD_VECTORS
    COHSM__EACH(a.v[piece] = (cohsm__piece)(m.v[piece] & (cohsm__piece_ints)a.v[piece]))
#else
    COHSM__EACH(a.v[piece] = m.v[piece] ? a.v[piece] : 0.0f)
#endif
    return a;
}

/* Rounds towards 0. An int32_t must be able to hold each float. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__lanes_truncate(cohsm__lanes a)
{
    cohsm__lane_ints k;
#if COHSM__SIMD_VECTORS
    COHSM__EACH(k.v[piece] = __builtin_convertvector(a.v[piece], cohsm__piece_ints))
#else
    COHSM__EACH(k.v[piece] = (int32_t)a.v[piece])
#endif
    return k;
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes_of_ints(cohsm__lane_ints k)
{
    cohsm__lanes a;
#if COHSM__SIMD_VECTORS           /* + 0: of 0 that was truncated from -0.5, gcc 12 makes -0 for NEON */
    COHSM__EACH(a.v[piece] = __builtin_convertvector(k.v[piece], cohsm__piece) + 0.0f)
#else
    COHSM__EACH(a.v[piece] = (float)k.v[piece])
#endif
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__mask_and(cohsm__lane_mask m, cohsm__lane_mask n)
{
    COHSM__EACH(m.v[piece] = m.v[piece] & n.v[piece])
    return m;
}

static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__mask_or(cohsm__lane_mask m, cohsm__lane_mask n)
{
    COHSM__EACH(m.v[piece] = m.v[piece] | n.v[piece])
    return m;
}

/* Returns the mask as bits: bit l is that of lane l. */
static inline COHSM__IN_KERNEL uint32_t cohsm__mask_bits(cohsm__lane_mask m)
{
    uint32_t bits = 0;
#if COHSM__SIMD_VECTORS
    int k;
    COHSM__EACH(for (k = 0; k < 4; k++) bits |= ((uint32_t)m.v[piece][k] & 1u) << (piece * COHSM__WIDTH + k))
#else
    COHSM__EACH(bits |= ((uint32_t)m.v[piece] & 1u) << piece)
#endif
    return bits;
}

static inline COHSM__IN_KERNEL int cohsm__mask_any(cohsm__lane_mask m)
{
    int any = 0;
#if COHSM__SIMD_VECTORS
    COHSM__EACH(any |= m.v[piece][0] | m.v[piece][1] | m.v[piece][2] | m.v[piece][3])
#else
    COHSM__EACH(any |= m.v[piece])
#endif
    return any != 0;
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_load(const int32_t *from)
{
    cohsm__lane_ints k;
    COHSM__EACH(memcpy(&k.v[piece], from + piece * COHSM__WIDTH, sizeof k.v[piece]))
    return k;
}

static inline COHSM__IN_KERNEL void cohsm__ints_store(int32_t *to, cohsm__lane_ints k)
{
    COHSM__EACH(memcpy(to + piece * COHSM__WIDTH, &k.v[piece], sizeof k.v[piece]))
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_all(int32_t x)
{
    cohsm__lane_ints k;
#if COHSM__SIMD_VECTORS
    const cohsm__piece_ints all = { x, x, x, x };
    COHSM__EACH(k.v[piece] = all)
#else
    COHSM__EACH(k.v[piece] = x)
#endif
    return k;
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_add(cohsm__lane_ints k, cohsm__lane_ints n)
{
    COHSM__EACH(k.v[piece] = (cohsm__piece_ints)((cohsm__piece_words)k.v[piece] + (cohsm__piece_words)n.v[piece]))
    return k;
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_sub(cohsm__lane_ints k, cohsm__lane_ints n)
{
    COHSM__EACH(k.v[piece] = (cohsm__piece_ints)((cohsm__piece_words)k.v[piece] - (cohsm__piece_words)n.v[piece]))
    return k;
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_or(cohsm__lane_ints k, cohsm__lane_ints n)
{
    COHSM__EACH(k.v[piece] = k.v[piece] | n.v[piece])
    return k;
}

/* Returns m ? k : 0. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_keep(cohsm__lane_mask m, cohsm__lane_ints k)
{
    COHSM__EACH(k.v[piece] = m.v[piece] & k.v[piece])
    return k;
}

static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__ints_equal(cohsm__lane_ints k, cohsm__lane_ints n)
{
    cohsm__lane_mask m;
#if COHSM__SIMD_VECTORS
    COHSM__EACH(m.v[piece] = k.v[piece] == n.v[piece])
#else
    COHSM__EACH(m.v[piece] = -(k.v[piece] == n.v[piece]))
#endif
    return m;
}

#endif

/* ==== src/shared/simd_lanes3.h ==== */

/* unit simd_lanes3, needs simd_begin: vectors of three in lanes */

typedef struct cohsm__lanes3 { cohsm__lanes x, y, z; } cohsm__lanes3;

static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__lanes3_load(const float *x, const float *y, const float *z)
{
    cohsm__lanes3 a;
    a.x = cohsm__lanes_load(x);
    a.y = cohsm__lanes_load(y);
    a.z = cohsm__lanes_load(z);
    return a;
}

/* Loads x, y, z of the first lane, then those of the next, and so on. */
static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__lanes3_load_packed(const float *xyz)
{
    cohsm__lanes3 v;
#if COHSM__WIDTH == 16
    static const int32_t from[16] = { 0, 3, 6, 9, 12, 15, 18, 21, 24, 27, 30, 33, 36, 39, 42, 45 };
    static const int32_t next[16] = { 1, 4, 7, 10, 13, 16, 19, 22, 25, 28, 31, 34, 37, 40, 43, 46 };
    static const int32_t last[16] = { 2, 5, 8, 11, 14, 17, 20, 23, 26, 29, 32, 35, 38, 41, 44, 47 };
    COHSM__EACH(
        const float *at = xyz + 3 * COHSM__WIDTH * piece;
        const __m512 a = _mm512_loadu_ps(at);
        const __m512 b = _mm512_loadu_ps(at + 16);
        const __m512 c = _mm512_loadu_ps(at + 32);
        const __m512i i = _mm512_loadu_si512(from);
        const __m512i j = _mm512_loadu_si512(next);
        const __m512i k = _mm512_loadu_si512(last);
        v.x.v[piece] = _mm512_mask_permutexvar_ps(_mm512_permutex2var_ps(a, i, b), (__mmask16)0xf800, i, c);
        v.y.v[piece] = _mm512_mask_permutexvar_ps(_mm512_permutex2var_ps(a, j, b), (__mmask16)0xf800, j, c);
        v.z.v[piece] = _mm512_mask_permutexvar_ps(_mm512_permutex2var_ps(a, k, b), (__mmask16)0xfc00, k, c))
#elif COHSM__WIDTH == 8                          /* in each half: a = x y z x, b = y z x y, c = z x y z */
    COHSM__EACH(
        const float *at = xyz + 3 * COHSM__WIDTH * piece;
        const __m256 a = _mm256_insertf128_ps(
            _mm256_castps128_ps256(_mm_loadu_ps(at)), _mm_loadu_ps(at + 12), 1);
        const __m256 b = _mm256_insertf128_ps(
            _mm256_castps128_ps256(_mm_loadu_ps(at + 4)), _mm_loadu_ps(at + 16), 1);
        const __m256 c = _mm256_insertf128_ps(
            _mm256_castps128_ps256(_mm_loadu_ps(at + 8)), _mm_loadu_ps(at + 20), 1);
        const __m256 ab = _mm256_shuffle_ps(a, b, _MM_SHUFFLE(1, 0, 2, 1));
        const __m256 bc = _mm256_shuffle_ps(b, c, _MM_SHUFFLE(2, 1, 3, 2));
        v.x.v[piece] = _mm256_shuffle_ps(a, bc, _MM_SHUFFLE(2, 0, 3, 0));
        v.y.v[piece] = _mm256_shuffle_ps(ab, bc, _MM_SHUFFLE(3, 1, 2, 0));
        v.z.v[piece] = _mm256_shuffle_ps(ab, c, _MM_SHUFFLE(3, 0, 3, 1)))
#else
    float x[COHSM__LANE_COUNT], y[COHSM__LANE_COUNT], z[COHSM__LANE_COUNT];
    int l;
    for (l = 0; l < COHSM__LANE_COUNT; l++) {
        x[l] = xyz[3 * l];
        y[l] = xyz[3 * l + 1];
        z[l] = xyz[3 * l + 2];
    }
    v = cohsm__lanes3_load(x, y, z);
#endif
    return v;
}

static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__lanes3_all(float x, float y, float z)
{
    cohsm__lanes3 a;
    a.x = cohsm__lanes_all(x);
    a.y = cohsm__lanes_all(y);
    a.z = cohsm__lanes_all(z);
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__lanes3_sub(cohsm__lanes3 a, cohsm__lanes3 b)
{
    a.x = cohsm__lanes_sub(a.x, b.x);
    a.y = cohsm__lanes_sub(a.y, b.y);
    a.z = cohsm__lanes_sub(a.z, b.z);
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__lanes3_scale(cohsm__lanes3 a, cohsm__lanes s)
{
    a.x = cohsm__lanes_mul(a.x, s);
    a.y = cohsm__lanes_mul(a.y, s);
    a.z = cohsm__lanes_mul(a.z, s);
    return a;
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__lanes3_dot(cohsm__lanes3 a, cohsm__lanes3 b)
{
    return cohsm__lanes_add(cohsm__lanes_add(cohsm__lanes_mul(a.x, b.x), cohsm__lanes_mul(a.y, b.y)),
                       cohsm__lanes_mul(a.z, b.z));
}

/* ==== src/shared/simd_strided.h ==== */

/* unit simd_strided, needs simd_lanes3: vectors of three that lie any number of bytes apart */

#define cohsm__load_pair COHSM__NAME_IN_SET(cohsm__load_pair, COHSM__SET)
#define cohsm__load_eight COHSM__NAME_IN_SET(cohsm__load_eight, COHSM__SET)
#define cohsm__join_halves COHSM__NAME_IN_SET(cohsm__join_halves, COHSM__SET)
#define cohsm__lanes3_load_fours COHSM__NAME_IN_SET(cohsm__lanes3_load_fours, COHSM__SET)

#if COHSM__WIDTH > 4
/* Loads vectors number 0 and 4, which lie `stride` bytes apart, and the 4 bytes behind each. */
static inline COHSM__IN_KERNEL __m256 cohsm__load_pair(const char *from, size_t stride)
{
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps((const float *)(const void *)from)),
                                _mm_loadu_ps((const float *)(const void *)(from + 4 * stride)), 1);
}

/* Loads x, y and z of 8 vectors, which lie `stride` bytes apart. Reads 4 bytes behind each. */
static inline COHSM__IN_KERNEL void cohsm__load_eight(const char *from, size_t stride, __m256 *xyz)
{
    const __m256 a = cohsm__load_pair(from, stride), b = cohsm__load_pair(from + stride, stride);
    const __m256 c = cohsm__load_pair(from + 2 * stride, stride), d = cohsm__load_pair(from + 3 * stride, stride);
    const __m256 ab = _mm256_unpacklo_ps(a, b), cd = _mm256_unpacklo_ps(c, d);
    xyz[0] = _mm256_shuffle_ps(ab, cd, _MM_SHUFFLE(1, 0, 1, 0));
    xyz[1] = _mm256_shuffle_ps(ab, cd, _MM_SHUFFLE(3, 2, 3, 2));
    xyz[2] = _mm256_shuffle_ps(_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d), _MM_SHUFFLE(1, 0, 1, 0));
}
#endif

#if COHSM__WIDTH == 16
/* Returns 16 floats of two halves. gcc 12 warns of what the insertion without a mask calls. */
static inline COHSM__IN_KERNEL __m512 cohsm__join_halves(__m256 low, __m256 high)
{
    return _mm512_castpd_ps(_mm512_maskz_insertf64x4(
        (__mmask8)0xff, _mm512_castps_pd(_mm512_castps256_ps512(low)), _mm256_castps_pd(high), 1));
}
#endif

/* Loads x, y, z of each lane from vectors that lie `stride` bytes apart. Reads 4 bytes behind each. */
static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__lanes3_load_fours(const void *from, size_t stride)
{
    const char *at = (const char *)from;
    cohsm__lanes3 v;
#if COHSM__WIDTH == 16
    __m256 low[3], high[3];
    COHSM__EACH(
        cohsm__load_eight(at + stride * (16 * piece), stride, low);
        cohsm__load_eight(at + stride * (16 * piece + 8), stride, high);
        v.x.v[piece] = cohsm__join_halves(low[0], high[0]);
        v.y.v[piece] = cohsm__join_halves(low[1], high[1]);
        v.z.v[piece] = cohsm__join_halves(low[2], high[2]))
#elif COHSM__WIDTH == 8
    __m256 xyz[3];
    COHSM__EACH(
        cohsm__load_eight(at + stride * (8 * piece), stride, xyz);
        v.x.v[piece] = xyz[0];
        v.y.v[piece] = xyz[1];
        v.z.v[piece] = xyz[2])
#else
    float xyz[3][COHSM__LANE_COUNT];
    int l, k;
    for (l = 0; l < COHSM__LANE_COUNT; l++)
        for (k = 0; k < 3; k++) memcpy(&xyz[k][l], at + stride * (size_t)l + 4 * k, 4);
    v = cohsm__lanes3_load(xyz[0], xyz[1], xyz[2]);
#endif
    return v;
}

/* ==== src/shared/simd_ints.h ==== */

/* unit simd_ints, needs simd_begin bits: whole numbers in lanes, lanes of a mask in a row, single bits */

#define cohsm__ints_mul COHSM__NAME_IN_SET(cohsm__ints_mul, COHSM__SET)
#define cohsm__ints_greater COHSM__NAME_IN_SET(cohsm__ints_greater, COHSM__SET)
#define cohsm__ints_select COHSM__NAME_IN_SET(cohsm__ints_select, COHSM__SET)
#define cohsm__ints_min COHSM__NAME_IN_SET(cohsm__ints_min, COHSM__SET)
#define cohsm__ints_max COHSM__NAME_IN_SET(cohsm__ints_max, COHSM__SET)
#define cohsm__ints_shift_right COHSM__NAME_IN_SET(cohsm__ints_shift_right, COHSM__SET)
#define cohsm__ints_append COHSM__NAME_IN_SET(cohsm__ints_append, COHSM__SET)
#define cohsm__lanes_append COHSM__NAME_IN_SET(cohsm__lanes_append, COHSM__SET)
#define cohsm__lanes_first COHSM__NAME_IN_SET(cohsm__lanes_first, COHSM__SET)
#define cohsm__mask_count COHSM__NAME_IN_SET(cohsm__mask_count, COHSM__SET)
#define cohsm__first_bit COHSM__NAME_IN_SET(cohsm__first_bit, COHSM__SET)
#define cohsm__bit_count COHSM__NAME_IN_SET(cohsm__bit_count, COHSM__SET)
#define cohsm__nth_bit COHSM__NAME_IN_SET(cohsm__nth_bit, COHSM__SET)
#define cohsm__halves_of16 COHSM__NAME_IN_SET(cohsm__halves_of16, COHSM__SET)
#define cohsm__halves_up_to COHSM__NAME_IN_SET(cohsm__halves_up_to, COHSM__SET)
#define cohsm__ints_and COHSM__NAME_IN_SET(cohsm__ints_and, COHSM__SET)
#define cohsm__ints_xor COHSM__NAME_IN_SET(cohsm__ints_xor, COHSM__SET)
#define cohsm__ints_join_halves COHSM__NAME_IN_SET(cohsm__ints_join_halves, COHSM__SET)
#define cohsm__ints_cross_halves COHSM__NAME_IN_SET(cohsm__ints_cross_halves, COHSM__SET)
#define cohsm__ints_gather COHSM__NAME_IN_SET(cohsm__ints_gather, COHSM__SET)

/* Returns the low 32 bits of products, so that signs do not matter. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_mul(cohsm__lane_ints k, cohsm__lane_ints n)
{
#if COHSM__WIDTH > 4
    COHSM__EACH(k.v[piece] = COHSM__INTEL(mullo_epi32)(k.v[piece], n.v[piece]))
#elif COHSM__SIMD_X86                            /* SSE2 has products of lanes 0 and 2, in 64 bits */
    COHSM__EACH(
        const __m128i even = _mm_mul_epu32(k.v[piece], n.v[piece]);
        const __m128i odd = _mm_mul_epu32(_mm_srli_epi64(k.v[piece], 32), _mm_srli_epi64(n.v[piece], 32));
        k.v[piece] = _mm_unpacklo_epi32(_mm_shuffle_epi32(even, 8), _mm_shuffle_epi32(odd, 8)))
#else
    COHSM__EACH(k.v[piece] = (cohsm__piece_ints)((cohsm__piece_words)k.v[piece] * (cohsm__piece_words)n.v[piece]))
#endif
    return k;
}

static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__ints_greater(cohsm__lane_ints k, cohsm__lane_ints n)
{
    cohsm__lane_mask m;
#if COHSM__WIDTH == 16
    COHSM__EACH(m.v[piece] = _mm512_cmpgt_epi32_mask(k.v[piece], n.v[piece]))
#elif COHSM__WIDTH == 8
    COHSM__EACH(m.v[piece] = _mm256_castsi256_ps(_mm256_cmpgt_epi32(k.v[piece], n.v[piece])))
#elif COHSM__SIMD_X86
    COHSM__EACH(m.v[piece] = _mm_castsi128_ps(_mm_cmpgt_epi32(k.v[piece], n.v[piece])))
#elif COHSM__SIMD_VECTORS
    COHSM__EACH(m.v[piece] = k.v[piece] > n.v[piece])
#else
    COHSM__EACH(m.v[piece] = -(k.v[piece] > n.v[piece]))
#endif
    return m;
}

/* Returns m ? k : n in each lane. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_select(cohsm__lane_mask m, cohsm__lane_ints k,
                                                    cohsm__lane_ints n)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(k.v[piece] = _mm512_mask_mov_epi32(n.v[piece], m.v[piece], k.v[piece]))
#elif COHSM__WIDTH == 8
    COHSM__EACH(k.v[piece] = _mm256_blendv_epi8(n.v[piece], k.v[piece], _mm256_castps_si256(m.v[piece])))
#elif COHSM__SIMD_X86
    COHSM__EACH(
        const __m128i mask = _mm_castps_si128(m.v[piece]);
        k.v[piece] = _mm_or_si128(_mm_and_si128(mask, k.v[piece]), _mm_andnot_si128(mask, n.v[piece])))
#else
    COHSM__EACH(k.v[piece] = (m.v[piece] & k.v[piece]) | (~m.v[piece] & n.v[piece]))
#endif
    return k;
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_min(cohsm__lane_ints k, cohsm__lane_ints n)
{
#if COHSM__WIDTH == 16                           /* gcc 12 warns of what min without a mask calls */
    COHSM__EACH(k.v[piece] = _mm512_maskz_min_epi32((__mmask16)0xffff, k.v[piece], n.v[piece]))
    return k;
#elif COHSM__WIDTH == 8
    COHSM__EACH(k.v[piece] = _mm256_min_epi32(k.v[piece], n.v[piece]))
    return k;
#else
    return cohsm__ints_select(cohsm__ints_greater(n, k), k, n);
#endif
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_max(cohsm__lane_ints k, cohsm__lane_ints n)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(k.v[piece] = _mm512_maskz_max_epi32((__mmask16)0xffff, k.v[piece], n.v[piece]))
    return k;
#elif COHSM__WIDTH == 8
    COHSM__EACH(k.v[piece] = _mm256_max_epi32(k.v[piece], n.v[piece]))
    return k;
#else
    return cohsm__ints_select(cohsm__ints_greater(k, n), k, n);
#endif
}

/* Returns k / 2^n, rounded down. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_shift_right(cohsm__lane_ints k, int n)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(k.v[piece] = _mm512_maskz_srav_epi32((__mmask16)0xffff, k.v[piece], _mm512_set1_epi32(n)))
#elif COHSM__WIDTH == 8
    COHSM__EACH(k.v[piece] = _mm256_srai_epi32(k.v[piece], n))
#elif COHSM__SIMD_X86
    COHSM__EACH(k.v[piece] = _mm_srai_epi32(k.v[piece], n))
#else
    COHSM__EACH(k.v[piece] = k.v[piece] >> n)
#endif
    return k;
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_and(cohsm__lane_ints k, cohsm__lane_ints n)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(k.v[piece] = _mm512_and_si512(k.v[piece], n.v[piece]))
#elif COHSM__WIDTH == 8
    COHSM__EACH(k.v[piece] = _mm256_and_si256(k.v[piece], n.v[piece]))
#elif COHSM__SIMD_X86
    COHSM__EACH(k.v[piece] = _mm_and_si128(k.v[piece], n.v[piece]))
#else
    COHSM__EACH(k.v[piece] = k.v[piece] & n.v[piece])
#endif
    return k;
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_xor(cohsm__lane_ints k, cohsm__lane_ints n)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(k.v[piece] = _mm512_xor_si512(k.v[piece], n.v[piece]))
#elif COHSM__WIDTH == 8
    COHSM__EACH(k.v[piece] = _mm256_xor_si256(k.v[piece], n.v[piece]))
#elif COHSM__SIMD_X86
    COHSM__EACH(k.v[piece] = _mm_xor_si128(k.v[piece], n.v[piece]))
#else
    COHSM__EACH(k.v[piece] = k.v[piece] ^ n.v[piece])
#endif
    return k;
}

/* Returns the low halves of k below those of n. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_join_halves(cohsm__lane_ints k, cohsm__lane_ints n)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(
        const __m512i high = _mm512_maskz_slli_epi32((__mmask16)0xffff, n.v[piece], 16);
        k.v[piece] = _mm512_mask_blend_epi16((__mmask32)0x55555555, high, k.v[piece]))
#elif COHSM__WIDTH == 8
    COHSM__EACH(k.v[piece] = _mm256_blend_epi16(_mm256_slli_epi32(n.v[piece], 16), k.v[piece], 0x55))
#elif COHSM__SIMD_X86
    COHSM__EACH(k.v[piece] = _mm_or_si128(_mm_slli_epi32(n.v[piece], 16),
                                     _mm_and_si128(k.v[piece], _mm_set1_epi32(0xffff))))
#else
    COHSM__EACH(
        const cohsm__piece_words high = (cohsm__piece_words)n.v[piece] << 16;
        k.v[piece] = (cohsm__piece_ints)(high | ((cohsm__piece_words)k.v[piece] & 0xffffu)))
#endif
    return k;
}

/* Returns kx ny - nx ky, where x is the low half of a number and y the high half, both with a sign; x of n is
   not the least that a half can be. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_cross_halves(cohsm__lane_ints k, cohsm__lane_ints n)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(
        const __m512i turned = _mm512_maskz_rol_epi32((__mmask16)0xffff, n.v[piece], 16);
        const __m512i zero = _mm512_setzero_si512();
        k.v[piece] = _mm512_madd_epi16(
            k.v[piece], _mm512_mask_sub_epi16(turned, (__mmask32)0xaaaaaaaau, zero, turned)))
#elif COHSM__WIDTH == 8
    COHSM__EACH(
        const __m256i turned = _mm256_shufflehi_epi16(_mm256_shufflelo_epi16(n.v[piece], 0xb1), 0xb1);
        k.v[piece] = _mm256_madd_epi16(
            k.v[piece], _mm256_sign_epi16(turned, _mm256_set1_epi32((int)0xffff0001u))))
#elif COHSM__SIMD_X86
    COHSM__EACH(
        const __m128i y = _mm_srli_epi32(n.v[piece], 16), x = _mm_slli_epi32(n.v[piece], 16);
        k.v[piece] = _mm_madd_epi16(k.v[piece], _mm_or_si128(y, _mm_sub_epi32(_mm_setzero_si128(), x))))
#else
    COHSM__EACH(
        const cohsm__piece_ints kx = (cohsm__piece_ints)((cohsm__piece_words)k.v[piece] << 16) >> 16;
        const cohsm__piece_ints nx = (cohsm__piece_ints)((cohsm__piece_words)n.v[piece] << 16) >> 16;
        k.v[piece] = kx * (n.v[piece] >> 16) - nx * (k.v[piece] >> 16))
#endif
    return k;
}

/* Returns from[k] for each lane's k. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__ints_gather(const int32_t *from, cohsm__lane_ints at)
{
#if COHSM__WIDTH == 16 && (defined(__OPTIMIZE__) || !defined(__GNUC__) || defined(__clang__))
    const __m512i none = _mm512_setzero_si512();        /* the gather of gcc -O0 turns signs */
    COHSM__EACH(at.v[piece] = _mm512_mask_i32gather_epi32(
               none, (__mmask16)0xffff, at.v[piece], (const void *)from, 4))
    return at;
#elif COHSM__WIDTH == 8
    COHSM__EACH(at.v[piece] = _mm256_i32gather_epi32((const int *)from, at.v[piece], 4))
    return at;
#else
    int32_t all[COHSM__LANE_COUNT];
    int l;
    cohsm__ints_store(all, at);
    for (l = 0; l < COHSM__LANE_COUNT; l++) all[l] = from[all[l]];
    return cohsm__ints_load(all);
#endif
}

/* Returns how many lanes are in a mask. */
static inline COHSM__IN_KERNEL uint32_t cohsm__mask_count(cohsm__lane_mask m)
{
#if COHSM__WIDTH > 4
    return (uint32_t)_mm_popcnt_u32(cohsm__mask_bits(m));
#else
    return cohsm__popcount(cohsm__mask_bits(m));
#endif
}

/* Returns the number of the lowest set bit; bits is not 0. */
static inline COHSM__IN_KERNEL uint32_t cohsm__first_bit(uint32_t bits)
{
#if COHSM__WIDTH > 4
    return _tzcnt_u32(bits);
#elif defined(__GNUC__) && !defined(__TINYC__)
    return (uint32_t)__builtin_ctz(bits);
#else
    return cohsm__popcount(~bits & (bits - 1u));
#endif
}

static inline COHSM__IN_KERNEL uint32_t cohsm__bit_count(uint64_t bits)
{
#if COHSM__WIDTH > 4 && (defined(__x86_64__) || defined(_M_X64))
    return (uint32_t)_mm_popcnt_u64(bits);
#else
    return cohsm__popcount(bits);
#endif
}

/* Does what cohsm__select_bit does, for a number below 64. */
static inline COHSM__IN_KERNEL uint32_t cohsm__nth_bit(uint64_t bits, uint32_t number)
{
#if COHSM__WIDTH > 4 && (defined(__x86_64__) || defined(_M_X64))
    return (uint32_t)_tzcnt_u64(_pdep_u64((uint64_t)1 << (number & 63u), bits));
#else
    return cohsm__select_bit(bits, number);
#endif
}

#if COHSM__WIDTH > 4
/* Does what cohsm__halves_up_to does for the half words of sixteen words, of which the first count are there. */
static inline COHSM__IN_KERNEL uint32_t cohsm__halves_of16(const uint32_t *words, uint32_t count, uint32_t limit)
{
    const __m256i limits = _mm256_set1_epi16((short)limit);
    const __m256i end = _mm256_set1_epi16((short)(count < 32u ? count : 32u));
    const __m256i number = _mm256_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    __m256i a = _mm256_loadu_si256((const __m256i *)(const void *)words);
    __m256i b = _mm256_loadu_si256((const __m256i *)(const void *)(words + 8));
    a = _mm256_and_si256(_mm256_cmpeq_epi16(_mm256_min_epu16(a, limits), a), _mm256_cmpgt_epi16(end, number));
    b = _mm256_and_si256(_mm256_cmpeq_epi16(_mm256_min_epu16(b, limits), b),
                         _mm256_cmpgt_epi16(end, _mm256_add_epi16(number, _mm256_set1_epi16(16))));
    return (uint32_t)_mm_popcnt_u32((uint32_t)_mm256_movemask_epi8(_mm256_packs_epi16(a, b)));
}
#endif

/* Returns how many of the first count half words, which ascend, the low half of each word first, are at most
   the limit. Words are read sixteen at a time. */
static inline COHSM__IN_KERNEL uint32_t cohsm__halves_up_to(const uint32_t *words, uint32_t count, uint32_t limit)
{
#if COHSM__WIDTH > 4
    uint32_t n = cohsm__halves_of16(words, count, limit), at;
    for (at = 32; at < count; at += 32) n += cohsm__halves_of16(words + at / 2, count - at, limit);
#else
    uint32_t n = 0, half, at;
    for (count++; count > 1; count -= half) {               /* halving without branches */
        half = count / 2;
        at = n + half - 1u;
        n += half & (0u - (uint32_t)((words[at >> 1] >> 16 * (at & 1u) & 0xffffu) <= limit));
    }
#endif
    return n;
}

#if COHSM__WIDTH == 8 && (defined(__x86_64__) || defined(_M_X64))
/* Returns the numbers of the lanes that are in a mask, one after the other from lane 0 on. */
static inline COHSM__IN_KERNEL __m256i cohsm__lanes_first(uint32_t bits)
{
    const uint64_t bytes = _pext_u64(0x0706050403020100u, _pdep_u64(bits, 0x0101010101010101u) * 255u);
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)bytes));
}
#endif

/* Writes the lanes of a mask one after the other. After them anything may be written, up to as many floats
   as there are lanes. */
static inline COHSM__IN_KERNEL void cohsm__lanes_append(float *to, cohsm__lane_mask m, cohsm__lanes a)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(
        _mm512_storeu_ps(to, _mm512_maskz_compress_ps(m.v[piece], a.v[piece]));
        to += _mm_popcnt_u32(m.v[piece]))
#elif COHSM__WIDTH == 8 && (defined(__x86_64__) || defined(_M_X64))
    COHSM__EACH(
        const uint32_t bits = (uint32_t)_mm256_movemask_ps(m.v[piece]);
        _mm256_storeu_ps(to, _mm256_permutevar8x32_ps(a.v[piece], cohsm__lanes_first(bits)));
        to += _mm_popcnt_u32(bits))
#else
    float all[COHSM__LANE_COUNT];
    uint32_t bits = cohsm__mask_bits(m);
    cohsm__lanes_store(all, a);
    for (; bits; bits &= bits - 1u) *to++ = all[cohsm__first_bit(bits)];
#endif
}

static inline COHSM__IN_KERNEL void cohsm__ints_append(int32_t *to, cohsm__lane_mask m, cohsm__lane_ints k)
{
#if COHSM__WIDTH == 16
    COHSM__EACH(
        _mm512_storeu_si512((void *)to, _mm512_maskz_compress_epi32(m.v[piece], k.v[piece]));
        to += _mm_popcnt_u32(m.v[piece]))
#elif COHSM__WIDTH == 8 && (defined(__x86_64__) || defined(_M_X64))
    COHSM__EACH(
        const uint32_t bits = (uint32_t)_mm256_movemask_ps(m.v[piece]);
        const __m256i first = _mm256_permutevar8x32_epi32(k.v[piece], cohsm__lanes_first(bits));
        _mm256_storeu_si256((__m256i *)(void *)to, first);
        to += _mm_popcnt_u32(bits))
#else
    int32_t all[COHSM__LANE_COUNT];
    uint32_t bits = cohsm__mask_bits(m);
    cohsm__ints_store(all, k);
    for (; bits; bits &= bits - 1u) *to++ = all[cohsm__first_bit(bits)];
#endif
}

/* ==== src/shared/simd_bytes.h ==== */

/* unit simd_bytes, needs simd_begin simd_ints: bytes that are compared 32 at a time */

#define cohsm__bytes_up_to COHSM__NAME_IN_SET(cohsm__bytes_up_to, COHSM__SET)

/* Returns how many of the bytes from..from + count - 1 are at most the limit. from and count are below 32;
   all of 32 bytes are read. */
static inline COHSM__IN_KERNEL uint32_t cohsm__bytes_up_to(const uint8_t *bytes, uint32_t from, uint32_t count,
                                                 uint32_t limit)
{
#if COHSM__WIDTH > 4
    const __m256i b = _mm256_loadu_si256((const __m256i *)(const void *)bytes);
    const __m256i least = _mm256_min_epu8(b, _mm256_set1_epi8((char)limit));
    const uint32_t mask = (uint32_t)_mm256_movemask_epi8(_mm256_cmpeq_epi8(least, b));
    return (uint32_t)_mm_popcnt_u32(_bzhi_u32(mask >> from, count));
#elif COHSM__SIMD_X86
    const __m128i limits = _mm_set1_epi8((char)limit);
    const __m128i a = _mm_loadu_si128((const __m128i *)(const void *)bytes);
    const __m128i b = _mm_loadu_si128((const __m128i *)(const void *)(bytes + 16));
    uint32_t mask = (uint32_t)_mm_movemask_epi8(_mm_cmpeq_epi8(_mm_min_epu8(a, limits), a));
    mask |= (uint32_t)_mm_movemask_epi8(_mm_cmpeq_epi8(_mm_min_epu8(b, limits), b)) << 16;
    return cohsm__bit_count(mask >> from & ((1u << count) - 1u));
#else
    uint8_t n = 0;                          /* bytes throughout, so that compilers vectorise it */
    int i;
    for (i = 0; i < 32; i++)
        n = (uint8_t)(n + ((bytes[i] <= (uint8_t)limit) & ((uint8_t)(i - (int)from) < (uint8_t)count)));
    return n;
#endif
}

/* ==== src/csm/kernels_raster.h ==== */

/* ---- kernels of raster: as many triangles as there are lanes ---- */

/* These kernels give what cohsm__fill_triangle gives, to the last bit. Nearly all boxes of a fine mesh hold
   no sample or a few: triangles with such boxes go through their samples together, a triangle a lane;
   triangles with larger boxes take cohsm__fill_triangle. */

typedef struct cohsm__triangles {
    cohsm__lane_ints x0, x1, x2;
    cohsm__lane_ints y0, y1, y2;
    cohsm__lanes z0, z1, z2;
} cohsm__triangles;

/* The samples of the triangles' boxes: columns lx..hx, rows ly..hy. */
typedef struct cohsm__spans { cohsm__lane_ints lx, hx, ly, hy; } cohsm__spans;

/* Writes the first and the last sample between the least and the greatest of three coordinates, also beyond
   the image; the first is the last one's successor where there is none. */
static inline COHSM__IN_KERNEL void cohsm__span(cohsm__lane_ints a, cohsm__lane_ints b, cohsm__lane_ints c,
                                                cohsm__lane_ints *low, cohsm__lane_ints *high)
{
    const cohsm__lane_ints l = cohsm__ints_min(cohsm__ints_min(a, b), c);
    const cohsm__lane_ints h = cohsm__ints_max(cohsm__ints_max(a, b), c);
    *low = cohsm__ints_shift_right(cohsm__ints_add(l, cohsm__ints_all(127)), 8);
    *high = cohsm__ints_shift_right(cohsm__ints_sub(h, cohsm__ints_all(128)), 8);
}

/* Leaves of a span the samples begin..end - 1. */
static inline COHSM__IN_KERNEL void cohsm__span_clamp(cohsm__lane_ints *low, cohsm__lane_ints *high,
                                                      int begin, int end)
{
    *low = cohsm__ints_max(*low, cohsm__ints_all(begin));
    *high = cohsm__ints_min(*high, cohsm__ints_all(end - 1));
}

/* Says which spans hold one of the samples begin..end - 1. */
static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__span_meets(cohsm__lane_ints low, cohsm__lane_ints high,
                                                                  int begin, int end)
{
    cohsm__span_clamp(&low, &high, begin, end);
    return cohsm__ints_greater(cohsm__ints_add(high, cohsm__ints_all(1)), low);
}

static inline COHSM__IN_KERNEL cohsm__spans cohsm__spans_of(const cohsm__target *t, const cohsm__triangles *p)
{
    cohsm__spans s;
    cohsm__span(p->x0, p->x1, p->x2, &s.lx, &s.hx);
    cohsm__span(p->y0, p->y1, p->y2, &s.ly, &s.hy);
    cohsm__span_clamp(&s.lx, &s.hx, 0, t->size);
    cohsm__span_clamp(&s.ly, &s.hy, t->row_begin, t->row_end);
    return s;
}

/* Enters the hits, whose depths are computed as many at a time as there are lanes. */
static inline COHSM__IN_KERNEL void cohsm__enter_hits(const cohsm__target *t, cohsm__hits *hits)
{
    const cohsm__lanes top = cohsm__lanes_all((float)COHSM__HIT_MAX);
    uint32_t i;

    for (i = 0; i < hits->count; i += COHSM__LANE_COUNT) {
        const cohsm__lanes area = cohsm__lanes_of_ints(cohsm__ints_load(hits->area + i));
        cohsm__lanes z = cohsm__lanes_div(cohsm__lanes_all(1.0f), area);
        z = cohsm__lanes_mul(cohsm__lanes_mul(cohsm__lanes_load(hits->sum + i), z), top);
        z = cohsm__lanes_min(cohsm__lanes_max(z, cohsm__lanes_all(0.0f)), top);
        cohsm__ints_store(hits->depth + i, cohsm__lanes_truncate(z));
    }
    cohsm__insert_hits(t, hits);
}

/* Notes one sample a lane as hit, for the lanes of a mask. */
static inline COHSM__IN_KERNEL void cohsm__note_hits(const cohsm__target *t, cohsm__lane_mask hit,
                                                     cohsm__lane_ints pixel, cohsm__lanes sum,
                                                     cohsm__lane_ints area, cohsm__hits *hits)
{
    cohsm__ints_append(hits->pixel + hits->count, hit, pixel);
    cohsm__lanes_append(hits->sum + hits->count, hit, sum);
    cohsm__ints_append(hits->area + hits->count, hit, area);
    hits->count += cohsm__mask_count(hit);
    if (hits->count > COHSM__MANY) cohsm__enter_hits(t, hits);
}

/* Twice the areas that a sample makes with the three sides of a triangle; w0 belongs to the side opposite
   corner 0, and so on. */
typedef struct cohsm__sides { cohsm__lane_ints w0, w1, w2; } cohsm__sides;

/* Returns twice the area that the side from a to b makes with the origin. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__side_from(cohsm__lane_ints ax, cohsm__lane_ints ay,
                                                                 cohsm__lane_ints bx, cohsm__lane_ints by)
{
    return cohsm__ints_sub(cohsm__ints_mul(ax, by), cohsm__ints_mul(bx, ay));
}

/* Returns what cohsm__edge_loses says as the number that the area must exceed: -1 if the side from a to b
   takes the samples exactly on it, else 0. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__side_loses(cohsm__lane_ints ax, cohsm__lane_ints ay,
                                                                  cohsm__lane_ints bx, cohsm__lane_ints by)
{
    const cohsm__lane_mask along = cohsm__mask_and(cohsm__ints_equal(by, ay), cohsm__ints_greater(bx, ax));
    return cohsm__ints_keep(cohsm__mask_or(cohsm__ints_greater(by, ay), along), cohsm__ints_all(-1));
}

static inline COHSM__IN_KERNEL cohsm__sides cohsm__sides_step(cohsm__sides s, const cohsm__sides *step)
{
    s.w0 = cohsm__ints_add(s.w0, step->w0);
    s.w1 = cohsm__ints_add(s.w1, step->w1);
    s.w2 = cohsm__ints_add(s.w2, step->w2);
    return s;
}

/* Returns the areas at sample (x, y). Relative to the sample x stays below 2^11, and y below 2^18, as of tall
   triangles in a shard of few rows, so that 32 bits are enough. */
static inline COHSM__IN_KERNEL cohsm__sides cohsm__side_areas(const cohsm__triangles *p, cohsm__lane_ints x,
                                                              cohsm__lane_ints y)
{
    const cohsm__lane_ints pixel = cohsm__ints_all(COHSM__SUBPIXEL);
    const cohsm__lane_ints middle = cohsm__ints_all(COHSM__SUBPIXEL / 2);
    const cohsm__lane_ints sx = cohsm__ints_add(cohsm__ints_mul(x, pixel), middle);
    const cohsm__lane_ints sy = cohsm__ints_add(cohsm__ints_mul(y, pixel), middle);
    const cohsm__lane_ints x0 = cohsm__ints_sub(p->x0, sx), y0 = cohsm__ints_sub(p->y0, sy);
    const cohsm__lane_ints x1 = cohsm__ints_sub(p->x1, sx), y1 = cohsm__ints_sub(p->y1, sy);
    const cohsm__lane_ints x2 = cohsm__ints_sub(p->x2, sx), y2 = cohsm__ints_sub(p->y2, sy);
    cohsm__sides s;
    s.w0 = cohsm__side_from(x1, y1, x2, y2);
    s.w1 = cohsm__side_from(x2, y2, x0, y0);
    s.w2 = cohsm__side_from(x0, y0, x1, y1);
    return s;
}

/* Swaps the last two corners of triangles that are seen from behind. */
static inline COHSM__IN_KERNEL void cohsm__to_front(cohsm__triangles *p, cohsm__lane_mask behind)
{
    const cohsm__lane_ints x1 = p->x1, y1 = p->y1;
    const cohsm__lanes z1 = p->z1;
    p->x1 = cohsm__ints_select(behind, p->x2, x1);
    p->y1 = cohsm__ints_select(behind, p->y2, y1);
    p->z1 = cohsm__lanes_select(behind, p->z2, z1);
    p->x2 = cohsm__ints_select(behind, x1, p->x2);
    p->y2 = cohsm__ints_select(behind, y1, p->y2);
    p->z2 = cohsm__lanes_select(behind, z1, p->z2);
}

/* Draws triangles by going through all samples of their boxes together. */
static inline COHSM__IN_KERNEL void cohsm__draw_boxes(const cohsm__target *t, cohsm__triangles *p,
                                                      const cohsm__spans *span, cohsm__lane_mask use,
                                                      cohsm__hits *hits)
{
    const cohsm__lane_ints zero = cohsm__ints_all(0), one = cohsm__ints_all(1);
    const cohsm__lane_ints pixel = cohsm__ints_all(COHSM__SUBPIXEL), size = cohsm__ints_all(t->size);
    cohsm__lane_ints area = cohsm__side_from(cohsm__ints_sub(p->x1, p->x0), cohsm__ints_sub(p->y1, p->y0),
                                             cohsm__ints_sub(p->x2, p->x0), cohsm__ints_sub(p->y2, p->y0));
    const cohsm__lane_ints end_x = cohsm__ints_add(span->hx, one), end_y = cohsm__ints_add(span->hy, one);
    cohsm__lane_ints loses0, loses1, loses2;
    cohsm__lane_ints x, y;
    cohsm__sides right, up, row, w;
    cohsm__lane_mask in_row, wanted;
    cohsm__lanes sum;

    cohsm__to_front(p, cohsm__ints_greater(zero, area));
    area = cohsm__ints_max(area, cohsm__ints_sub(zero, area));
    use = cohsm__mask_and(use, cohsm__ints_greater(area, zero));
    loses0 = cohsm__side_loses(p->x1, p->y1, p->x2, p->y2);
    loses1 = cohsm__side_loses(p->x2, p->y2, p->x0, p->y0);
    loses2 = cohsm__side_loses(p->x0, p->y0, p->x1, p->y1);
    right.w0 = cohsm__ints_mul(cohsm__ints_sub(p->y1, p->y2), pixel);
    right.w1 = cohsm__ints_mul(cohsm__ints_sub(p->y2, p->y0), pixel);
    right.w2 = cohsm__ints_mul(cohsm__ints_sub(p->y0, p->y1), pixel);
    up.w0 = cohsm__ints_mul(cohsm__ints_sub(p->x2, p->x1), pixel);
    up.w1 = cohsm__ints_mul(cohsm__ints_sub(p->x0, p->x2), pixel);
    up.w2 = cohsm__ints_mul(cohsm__ints_sub(p->x1, p->x0), pixel);
    row = cohsm__side_areas(p, span->lx, span->ly);
    for (y = span->ly;; y = cohsm__ints_add(y, one), row = cohsm__sides_step(row, &up)) {
        in_row = cohsm__mask_and(use, cohsm__ints_greater(end_y, y));
        if (!cohsm__mask_any(in_row)) break;
        for (x = span->lx, w = row;; x = cohsm__ints_add(x, one), w = cohsm__sides_step(w, &right)) {
            wanted = cohsm__mask_and(in_row, cohsm__ints_greater(end_x, x));
            if (!cohsm__mask_any(wanted)) break;
            wanted = cohsm__mask_and(wanted, cohsm__ints_greater(w.w0, loses0));
            wanted = cohsm__mask_and(wanted, cohsm__ints_greater(w.w1, loses1));
            wanted = cohsm__mask_and(wanted, cohsm__ints_greater(w.w2, loses2));
            if (COHSM__WIDTH == 1 && !cohsm__mask_any(wanted)) continue;
            sum = cohsm__lanes_mul(cohsm__lanes_of_ints(w.w0), p->z0);
            sum = cohsm__lanes_add(sum, cohsm__lanes_mul(cohsm__lanes_of_ints(w.w1), p->z1));
            sum = cohsm__lanes_add(sum, cohsm__lanes_mul(cohsm__lanes_of_ints(w.w2), p->z2));
            cohsm__note_hits(t, wanted, cohsm__ints_add(cohsm__ints_mul(y, size), x), sum, area, hits);
        }
    }
}

/* Draws one triangle of the queue by cohsm__fill_triangle. */
static inline COHSM__IN_KERNEL void cohsm__draw_alone(const cohsm__target *t, const cohsm__camera *cam,
                                                      const cohsm__queue *q, uint32_t at)
{
    cohsm__corner c[3];
    int k;
    for (k = 0; k < 3; k++) {
        c[k].x = q->x[k][at];
        c[k].y = q->y[k][at];
        c[k].z = q->z[k][at];
    }
    cohsm__fill_triangle(t, cam, NULL, c, c + 1, c + 2);
}

/* Draws the triangles of the queue from number at on, as many as there are lanes or are left. */
static inline COHSM__IN_KERNEL void cohsm__draw_some(const cohsm__target *t, const cohsm__camera *cam,
                                                     const cohsm__queue *q, uint32_t at, cohsm__hits *hits)
{
    const cohsm__lane_ints few = cohsm__ints_all(5), left = cohsm__ints_all((int32_t)(q->count - at));
    cohsm__lane_mask some, slight;
    cohsm__triangles p;
    cohsm__spans span;
    uint32_t large;

    p.x0 = cohsm__ints_load(q->x[0] + at);
    p.x1 = cohsm__ints_load(q->x[1] + at);
    p.x2 = cohsm__ints_load(q->x[2] + at);
    p.y0 = cohsm__ints_load(q->y[0] + at);
    p.y1 = cohsm__ints_load(q->y[1] + at);
    p.y2 = cohsm__ints_load(q->y[2] + at);
    p.z0 = cohsm__lanes_load(q->z[0] + at);
    p.z1 = cohsm__lanes_load(q->z[1] + at);
    p.z2 = cohsm__lanes_load(q->z[2] + at);
    span = cohsm__spans_of(t, &p);
    some = cohsm__ints_greater(left, cohsm__ints_load(cohsm__numbers));
    slight = cohsm__mask_and(some, cohsm__ints_greater(few, cohsm__ints_sub(span.hx, span.lx)));
    slight = cohsm__mask_and(slight, cohsm__ints_greater(few, cohsm__ints_sub(span.hy, span.ly)));
    large = cohsm__mask_bits(some) & ~cohsm__mask_bits(slight);
    for (; large; large &= large - 1u) cohsm__draw_alone(t, cam, q, at + cohsm__first_bit(large));
    if (cohsm__mask_any(slight)) cohsm__draw_boxes(t, &p, &span, slight, hits);
}

/* Draws specks from number at on, as many as there are lanes or are left. A sample is inside if it is on the
   same side of all three edges; one exactly on an edge counts as left of it, or as right of it, as
   cohsm__edge_loses has it for a triangle seen from in front. If the triangle is seen from behind, all
   areas are negative, and the sum of depths so, too; the order of its terms is that of
   cohsm__fill_triangle. */
static inline COHSM__IN_KERNEL void cohsm__draw_specks(const cohsm__target *t, const cohsm__specks *s,
                                                       uint32_t at, cohsm__hits *hits)
{
    const cohsm__lane_ints zero = cohsm__ints_all(0), minus = cohsm__ints_all(-1);
    const cohsm__lane_ints sign = cohsm__ints_all(0x8000), left = cohsm__ints_all((int32_t)(s->count - at));
    const cohsm__lane_ints p0 = cohsm__ints_load(s->corner[0] + at), k0 = cohsm__ints_xor(p0, sign);
    const cohsm__lane_ints p1 = cohsm__ints_load(s->corner[1] + at), k1 = cohsm__ints_xor(p1, sign);
    const cohsm__lane_ints p2 = cohsm__ints_load(s->corner[2] + at), k2 = cohsm__ints_xor(p2, sign);
    const cohsm__lane_ints w0 = cohsm__ints_cross_halves(p1, p2), w1 = cohsm__ints_cross_halves(p2, p0);
    const cohsm__lane_ints w2 = cohsm__ints_cross_halves(p0, p1);
    const cohsm__lane_ints area = cohsm__ints_add(cohsm__ints_add(w0, w1), w2);
    const cohsm__lane_ints side0 = cohsm__ints_add(w0, cohsm__ints_keep(cohsm__ints_greater(k1, k2), minus));
    const cohsm__lane_ints side1 = cohsm__ints_add(w1, cohsm__ints_keep(cohsm__ints_greater(k2, k0), minus));
    const cohsm__lane_ints side2 = cohsm__ints_add(w2, cohsm__ints_keep(cohsm__ints_greater(k0, k1), minus));
    const cohsm__lane_ints differ =
        cohsm__ints_or(cohsm__ints_xor(side0, side1), cohsm__ints_xor(side0, side2));
    const cohsm__lane_mask behind = cohsm__ints_greater(zero, area);
    const cohsm__lane_ints flat = cohsm__ints_xor(cohsm__ints_or(area, cohsm__ints_sub(zero, area)), minus);
    const cohsm__lane_mask inside = cohsm__ints_greater(cohsm__ints_or(differ, flat), minus);
    const cohsm__lane_mask some = cohsm__ints_greater(left, cohsm__ints_load(cohsm__numbers));
    const cohsm__lanes z0 = cohsm__lanes_mul(cohsm__lanes_of_ints(w0), cohsm__lanes_load(s->z[0] + at));
    const cohsm__lanes z1 = cohsm__lanes_mul(cohsm__lanes_of_ints(w1), cohsm__lanes_load(s->z[1] + at));
    const cohsm__lanes z2 = cohsm__lanes_mul(cohsm__lanes_of_ints(w2), cohsm__lanes_load(s->z[2] + at));
    const cohsm__lanes sum = cohsm__lanes_add(cohsm__lanes_add(z0, cohsm__lanes_select(behind, z2, z1)),
                                              cohsm__lanes_select(behind, z1, z2));
    cohsm__note_hits(t, cohsm__mask_and(some, inside), cohsm__ints_load(s->pixel + at), sum, area, hits);
}

/* Draws triangles of the queue, as long as there is one for each lane, and moves those that are left to the
   front. If all is not 0, draws those too. There is one function for both, since compilers need a second for
   each copy of cohsm__draw_some. */
COHSM__KERNEL static void cohsm__draw_queue(const cohsm__target *t, const cohsm__camera *cam, cohsm__queue *q,
                                            int all)
{
    const uint32_t most = all ? COHSM__LANE_COUNT - 1u : 0u;
    cohsm__specks *s = &q->specks;
    uint32_t at;
    int k;

    for (at = 0; at + COHSM__LANE_COUNT <= s->count + most; at += COHSM__LANE_COUNT)
        cohsm__draw_specks(t, s, at, &q->hits);
    for (k = 0; at && at < s->count && k < 3; k++) {
        memcpy(s->corner[k], s->corner[k] + at, COHSM__LANE_COUNT * sizeof s->corner[k][0]);
        memcpy(s->z[k], s->z[k] + at, COHSM__LANE_COUNT * sizeof s->z[k][0]);
    }
    if (at) memcpy(s->pixel, s->pixel + at, COHSM__LANE_COUNT * sizeof s->pixel[0]);
    s->count -= cohsm__min_u32(at, s->count);
    for (at = 0; at + COHSM__LANE_COUNT <= q->count + most; at += COHSM__LANE_COUNT)
        cohsm__draw_some(t, cam, q, at, &q->hits);
    for (k = 0; at && at < q->count && k < 3; k++) {
        memcpy(q->x[k], q->x[k] + at, COHSM__LANE_COUNT * sizeof q->x[k][0]);
        memcpy(q->y[k], q->y[k] + at, COHSM__LANE_COUNT * sizeof q->y[k][0]);
        memcpy(q->z[k], q->z[k] + at, COHSM__LANE_COUNT * sizeof q->z[k][0]);
    }
    q->count -= cohsm__min_u32(at, q->count);
    if (all) cohsm__enter_hits(t, &q->hits);
}

/* ==== src/csm/kernels_slabs.h ==== */

/* ---- kernels of raster: which triangles of a slab are drawn ---- */

/* Returns where sample number n of a row or column lies, in 1/256 pixel. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__sample_middle(cohsm__lane_ints n)
{
    return cohsm__ints_add(cohsm__ints_mul(n, cohsm__ints_all(COHSM__SUBPIXEL)),
                           cohsm__ints_all(COHSM__SUBPIXEL / 2));
}

/* Loads one corner of as many triangles as there are lanes, from rows of x, y and z that lie COHSM__CLUSTER
   floats apart. */
static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__corner_load(const float *v)
{
    return cohsm__lanes3_load(v, v + COHSM__CLUSTER, v + 2 * COHSM__CLUSTER);
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__fixed(cohsm__lanes3 corner, cohsm__lanes3 axis,
                                                             cohsm__lanes offset)
{
    return cohsm__lanes_truncate(cohsm__lanes_add(cohsm__lanes3_dot(corner, axis), offset));
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__depths(cohsm__lanes3 corner, cohsm__lanes3 half_back)
{
    return cohsm__lanes_sub(cohsm__lanes_all(0.5f), cohsm__lanes3_dot(corner, half_back));
}

/* Appends the triangles of a mask to those of the queue. */
static inline COHSM__IN_KERNEL void cohsm__queue_add(cohsm__queue *q, const cohsm__triangles *p,
                                                     cohsm__lane_mask m)
{
    const uint32_t at = q->count;
    cohsm__ints_append(q->x[0] + at, m, p->x0);
    cohsm__ints_append(q->x[1] + at, m, p->x1);
    cohsm__ints_append(q->x[2] + at, m, p->x2);
    cohsm__ints_append(q->y[0] + at, m, p->y0);
    cohsm__ints_append(q->y[1] + at, m, p->y1);
    cohsm__ints_append(q->y[2] + at, m, p->y2);
    cohsm__lanes_append(q->z[0] + at, m, p->z0);
    cohsm__lanes_append(q->z[1] + at, m, p->z1);
    cohsm__lanes_append(q->z[2] + at, m, p->z2);
    q->count = at + cohsm__mask_count(m);
}

/* The axes of an orthographic view, for positions on its image in 1/256 pixel from its lower left corner. */
typedef struct cohsm__image_axes {
    cohsm__lanes3 right, up, half_back;
    cohsm__lanes offset;
} cohsm__image_axes;

static inline COHSM__IN_KERNEL cohsm__image_axes cohsm__image_axes_of(const cohsm__target *t,
                                                                      const cohsm__axes *axes)
{
    const float scale = (float)(t->size * (COHSM__SUBPIXEL / 2));
    const cohsm__v3 r = cohsm__v3_scale(axes->right, scale), u = cohsm__v3_scale(axes->up, scale);
    cohsm__image_axes a;
    a.right = cohsm__lanes3_all(r.x, r.y, r.z);
    a.up = cohsm__lanes3_all(u.x, u.y, u.z);
    a.half_back = cohsm__lanes3_all(0.5f * axes->back.x, 0.5f * axes->back.y, 0.5f * axes->back.z);
    a.offset = cohsm__lanes_all(scale + 0.5f);
    return a;
}

/* Appends one corner of the triangles of a mask to number k of those of the slab. */
static inline COHSM__IN_KERNEL void cohsm__slab_corner(cohsm__slab *slab, int k, cohsm__lane_mask m,
                                                       const cohsm__lanes3 *corner, cohsm__lane_ints x,
                                                       cohsm__lane_ints middle)
{
    const uint32_t at = slab->count;
    cohsm__ints_append(slab->x[k] + at, m, x);
    cohsm__ints_append(slab->off[k] + at, m, cohsm__ints_sub(x, middle));
    cohsm__lanes_append(slab->corner[3 * k] + at, m, corner->x);
    cohsm__lanes_append(slab->corner[3 * k + 1] + at, m, corner->y);
    cohsm__lanes_append(slab->corner[3 * k + 2] + at, m, corner->z);
}

/* Appends the triangles that hold a sample column to those of the slab, with x of their corners. */
static inline COHSM__IN_KERNEL void cohsm__slab_add(cohsm__slab *slab, const cohsm__target *t,
                                                    const cohsm__image_axes *axes,
                                                    const cohsm__lanes3 *corner)
{
    const cohsm__lane_ints x0 = cohsm__fixed(corner[0], axes->right, axes->offset);
    const cohsm__lane_ints x1 = cohsm__fixed(corner[1], axes->right, axes->offset);
    const cohsm__lane_ints x2 = cohsm__fixed(corner[2], axes->right, axes->offset);
    cohsm__lane_ints low, high, middle, column;
    cohsm__lane_mask m;

    cohsm__span(x0, x1, x2, &low, &high);
    m = cohsm__span_meets(low, high, 0, t->size);
    middle = cohsm__sample_middle(low);
    column = cohsm__ints_select(cohsm__ints_equal(low, high), low, cohsm__ints_all(-1));
    cohsm__ints_append(slab->column + slab->count, m, column);
    cohsm__slab_corner(slab, 0, m, corner, x0, middle);
    cohsm__slab_corner(slab, 1, m, corner + 1, x1, middle);
    cohsm__slab_corner(slab, 2, m, corner + 2, x2, middle);
    slab->count += cohsm__mask_count(m);
}

/* Asks for the triangles of a part of a cluster, as many as there are lanes: what all views of a column read
   once does not stay in a cache. */
static inline COHSM__IN_KERNEL void cohsm__prefetch_part(const cohsm__soup *soup, uint32_t cluster,
                                                         uint32_t part)
{
    enum { FLOATS = 9 * COHSM__LANE_COUNT };
    const float *v = cohsm__cluster(soup, cluster) + FLOATS * part;
    int k;
    for (k = 0; k < FLOATS; k += 16) COHSM__PREFETCH(v + k);
}

/* Finds the triangles of a slab's clusters, which stand from `first` on in the list, that hold a sample
   column of all views with the right axis of this one. */
COHSM__KERNEL static void cohsm__find_slab(const cohsm__target *t, const cohsm__camera *cam,
                                            const cohsm__soup *soup, const cohsm__sight *sight,
                                            uint32_t first, cohsm__slab *slab)
{
    enum { PARTS = COHSM__CLUSTER / COHSM__LANE_COUNT };
    const cohsm__image_axes axes = cohsm__image_axes_of(t, &cam->axes);
    const uint32_t last = sight->count - 1u;
    const uint32_t end = cohsm__min_u32(first + (uint32_t)COHSM__SLAB / COHSM__CLUSTER, sight->count);
    uint32_t i;

    slab->count = 0;
    for (i = PARTS * first; i < PARTS * end; i++) {
        const float *v = cohsm__cluster(soup, sight->cluster[i / PARTS]) + COHSM__LANE_COUNT * (i % PARTS);
        const uint32_t ahead = cohsm__min_u32(i / PARTS + (uint32_t)COHSM__CLUSTERS_AHEAD, last);
        cohsm__lanes3 corner[3];
        cohsm__prefetch_part(soup, sight->cluster[ahead], i % PARTS);
        corner[0] = cohsm__corner_load(v);
        corner[1] = cohsm__corner_load(v + 3 * COHSM__CLUSTER);
        corner[2] = cohsm__corner_load(v + 6 * COHSM__CLUSTER);
        cohsm__slab_add(slab, t, &axes, corner);
    }
}

/* Appends the triangles of a mask to the specks, by y and depths of p; row is that of their samples. */
static inline COHSM__IN_KERNEL void cohsm__specks_add(const cohsm__target *t, const cohsm__slab *slab,
                                                      uint32_t from, const cohsm__triangles *p,
                                                      cohsm__lane_ints row, cohsm__lane_mask m,
                                                      cohsm__specks *s)
{
    const uint32_t at = s->count;
    const cohsm__lane_ints middle = cohsm__sample_middle(row), column = cohsm__ints_load(slab->column + from);
    const cohsm__lane_ints y0 = cohsm__ints_sub(p->y0, middle), y1 = cohsm__ints_sub(p->y1, middle);
    const cohsm__lane_ints y2 = cohsm__ints_sub(p->y2, middle);

    cohsm__ints_append(s->corner[0] + at, m,
                       cohsm__ints_join_halves(cohsm__ints_load(slab->off[0] + from), y0));
    cohsm__ints_append(s->corner[1] + at, m,
                       cohsm__ints_join_halves(cohsm__ints_load(slab->off[1] + from), y1));
    cohsm__ints_append(s->corner[2] + at, m,
                       cohsm__ints_join_halves(cohsm__ints_load(slab->off[2] + from), y2));
    cohsm__lanes_append(s->z[0] + at, m, p->z0);
    cohsm__lanes_append(s->z[1] + at, m, p->z1);
    cohsm__lanes_append(s->z[2] + at, m, p->z2);
    cohsm__ints_append(s->pixel + at, m,
                       cohsm__ints_add(cohsm__ints_mul(row, cohsm__ints_all(t->size)), column));
    s->count = at + cohsm__mask_count(m);
}

static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__slab_load(const cohsm__slab *slab, int k, uint32_t at)
{
    return cohsm__lanes3_load(slab->corner[3 * k] + at, slab->corner[3 * k + 1] + at,
                              slab->corner[3 * k + 2] + at);
}

/* Puts those triangles of a slab, from number at on, as many as there are lanes or are left, into the queue
   of a view that hold a sample row, or among its specks. */
static inline COHSM__IN_KERNEL void cohsm__enqueue_some(const cohsm__target *t,
                                                        const cohsm__image_axes *axes,
                                                        const cohsm__slab *slab, uint32_t at, cohsm__queue *q)
{
    const cohsm__lane_ints left = cohsm__ints_all((int32_t)(slab->count - at)), minus = cohsm__ints_all(-1);
    cohsm__lane_mask use = cohsm__ints_greater(left, cohsm__ints_load(cohsm__numbers)), speck;
    const cohsm__lanes3 corner0 = cohsm__slab_load(slab, 0, at), corner1 = cohsm__slab_load(slab, 1, at);
    const cohsm__lanes3 corner2 = cohsm__slab_load(slab, 2, at);
    cohsm__lane_ints low, high, column;
    cohsm__triangles p;

    p.y0 = cohsm__fixed(corner0, axes->up, axes->offset);
    p.y1 = cohsm__fixed(corner1, axes->up, axes->offset);
    p.y2 = cohsm__fixed(corner2, axes->up, axes->offset);
    p.z0 = cohsm__depths(corner0, axes->half_back);
    p.z1 = cohsm__depths(corner1, axes->half_back);
    p.z2 = cohsm__depths(corner2, axes->half_back);
    cohsm__span(p.y0, p.y1, p.y2, &low, &high);
    use = cohsm__mask_and(use, cohsm__span_meets(low, high, t->row_begin, t->row_end));
    column = cohsm__ints_select(cohsm__ints_equal(low, high), cohsm__ints_load(slab->column + at), minus);
    speck = cohsm__mask_and(use, cohsm__ints_greater(column, minus));
    if (cohsm__mask_any(speck)) cohsm__specks_add(t, slab, at, &p, low, speck, &q->specks);
    use = cohsm__mask_and(use, cohsm__ints_equal(column, minus));
    if (!cohsm__mask_any(use)) return;
    p.x0 = cohsm__ints_load(slab->x[0] + at);
    p.x1 = cohsm__ints_load(slab->x[1] + at);
    p.x2 = cohsm__ints_load(slab->x[2] + at);
    cohsm__queue_add(q, &p, use);
}

/* Puts the triangles of a slab into the queue of one of its views. */
COHSM__KERNEL static void cohsm__enqueue_slab(const cohsm__target *t, const cohsm__camera *cam,
                                              const cohsm__slab *slab, cohsm__queue *q)
{
    const cohsm__image_axes axes = cohsm__image_axes_of(t, &cam->axes);
    uint32_t at;

    for (at = 0; at < slab->count; at += COHSM__LANE_COUNT) {
        cohsm__enqueue_some(t, &axes, slab, at, q);
        if (q->count > COHSM__MANY || q->specks.count > COHSM__MANY) cohsm__draw_queue(t, cam, q, 0);
    }
}

#if COHSM__LANE_COUNT == 8

/* Says which of 8 clusters may cover samples of the wanted rows. Rounding moves corners by less than a
   hundredth of a pixel. */
static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__sees8(const cohsm__target *t, cohsm__v3 up,
                                                             const float *box)
{
    const cohsm__lanes half = cohsm__lanes_all(0.5f * (float)t->size), one = cohsm__lanes_all(1.0f);
    const cohsm__lanes3 middle = cohsm__lanes3_load(box, box + 8, box + 16);
    const cohsm__lanes3 side = cohsm__lanes3_load(box + 24, box + 32, box + 40);
    cohsm__lanes y = cohsm__lanes3_dot(middle, cohsm__lanes3_all(up.x, up.y, up.z));
    cohsm__lanes e = cohsm__lanes3_dot(side, cohsm__lanes3_all(fabsf(up.x), fabsf(up.y), fabsf(up.z)));
    y = cohsm__lanes_mul(cohsm__lanes_add(y, one), half);
    e = cohsm__lanes_add(cohsm__lanes_mul(e, half), cohsm__lanes_all(0.01f));
    return cohsm__mask_and(
        cohsm__lanes_at_least(cohsm__lanes_add(y, e), cohsm__lanes_all((float)t->row_begin + 0.5f)),
        cohsm__lanes_at_least(cohsm__lanes_all((float)t->row_end - 0.5f), cohsm__lanes_sub(y, e)));
}

/* Appends to a list the numbers, from first on, of the lanes of a mask, if they come before end. Returns the
   new count. */
static inline COHSM__IN_KERNEL uint32_t cohsm__append8(uint32_t *list, uint32_t count, cohsm__lane_mask mask,
                                                       uint32_t first, uint32_t end)
{
    const cohsm__lane_ints number =
        cohsm__ints_add(cohsm__ints_load(cohsm__numbers), cohsm__ints_all((int32_t)first));
    mask = cohsm__mask_and(mask, cohsm__ints_greater(cohsm__ints_all((int32_t)end), number));
    cohsm__ints_append((int32_t *)(void *)(list + count), mask, number);
    return count + cohsm__mask_count(mask);
}

/* Finds those of the clusters begin .. end - 1, no more than a stretch, that may be in sight of an
   orthographic view: by the boxes of eight clusters first. */
COHSM__KERNEL static void cohsm__find_clusters(const cohsm__target *t, cohsm__v3 up, const cohsm__soup *soup,
                                               uint32_t begin, uint32_t end, cohsm__sight *sight)
{
    const float *wide = cohsm__wide_bounds(soup);
    uint32_t eight[COHSM__STRETCH / 8 + 8], eights = cohsm__groups_of_8(end), count = 0, i;

    for (i = begin / 8; i < eights; i += 8)
        count = cohsm__append8(eight, count, cohsm__sees8(t, up, wide + 6 * (size_t)i), i, eights);
    for (i = 0, sight->count = 0; i < count; i++)
        sight->count =
            cohsm__append8(sight->cluster, sight->count,
                           cohsm__sees8(t, up, soup->bounds + 48 * (size_t)eight[i]), 8 * eight[i], end);
}

#endif

/* ==== src/csm/kernels_compress.h ==== */

/* ---- kernels of compress: as many pixels as there are lanes ---- */

/* Returns x / 65535, rounded down, for x in 0..2^24. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__divide_65535(cohsm__lane_ints x)
{
    const cohsm__lane_ints more = cohsm__ints_add(x, cohsm__ints_all(1));
    return cohsm__ints_shift_right(cohsm__ints_add(more, cohsm__ints_shift_right(x, 16)), 16);
}

/* Returns what cohsm__grid_above and cohsm__grid_below return. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__grid_above_lanes(cohsm__lane_ints depth, int32_t top)
{
    const cohsm__lane_ints scaled = cohsm__ints_mul(depth, cohsm__ints_all(top));
    return cohsm__divide_65535(cohsm__ints_add(scaled, cohsm__ints_all(65534)));
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__grid_below_lanes(cohsm__lane_ints depth, int32_t top)
{
    const cohsm__lane_ints scaled = cohsm__ints_mul(depth, cohsm__ints_all(top));
    return cohsm__divide_65535(cohsm__ints_add(scaled, cohsm__ints_all(top - 1)));
}

/* The interval that cohsm__interval gives for each pixel, what it returns, and which pixels have a first
   layer without a second. */
typedef struct cohsm__intervals { cohsm__lane_ints lo, hi; cohsm__lane_mask empty, open; } cohsm__intervals;

static inline COHSM__IN_KERNEL cohsm__intervals cohsm__intervals_of(const cohsm__narrowing *n,
                                                                    const uint16_t *z)
{
    const cohsm__lane_ints all = cohsm__ints_all(COHSM__INFINITE), one = cohsm__ints_all(1);
    const cohsm__lane_ints both = cohsm__ints_load((const int32_t *)(const void *)z);
    const cohsm__lane_ints z1 = cohsm__ints_and(both, all);
    const cohsm__lane_ints z2 = cohsm__ints_and(cohsm__ints_shift_right(both, 16), all);
    const cohsm__lane_mask hit = cohsm__ints_greater(all, z1), no_second = cohsm__ints_equal(z2, all);
    /* Farther than 65536 is as far. */
    const cohsm__lanes behind = cohsm__lanes_min(
        cohsm__lanes_add(cohsm__lanes_mul(cohsm__lanes_all(n->slope), cohsm__lanes_of_ints(z1)),
                         cohsm__lanes_all(n->gap)), cohsm__lanes_all(65536.0f));
    const cohsm__lane_ints open = cohsm__ints_add(cohsm__ints_add(z1, one), cohsm__lanes_truncate(behind));
    const cohsm__lane_ints upper = cohsm__ints_select(no_second, open, z2);
    const cohsm__lane_mask room = cohsm__ints_greater(upper, z1);
    cohsm__intervals i;

    i.hi = cohsm__ints_min(cohsm__ints_sub(upper, one), cohsm__ints_all(COHSM__OPEN));
    i.hi = cohsm__ints_select(hit, cohsm__ints_select(room, i.hi, z1), all);
    i.lo = cohsm__ints_select(hit, z1, cohsm__ints_all(n->miss));
    i.empty = cohsm__mask_and(hit, cohsm__ints_greater(one, cohsm__ints_sub(upper, z1)));
    i.open = cohsm__mask_and(hit, no_second);
    return i;
}

/* Adds a view of two layers to the open segments of pixels, as cohsm__compress_pixel does, but for those that
   end, and for the last few pixels that are not as many as there are lanes. These it writes into `left`,
   which has room for 16 more, and returns how many they are. */
COHSM__KERNEL static uint32_t cohsm__narrow(cohsm__narrowing *n, const uint16_t *z, int32_t *span,
                                            uint32_t pixels, int32_t *left)
{
    const cohsm__lane_ints low_half = cohsm__ints_all(65535);
    uint32_t p, count = 0;

    for (p = 0; p + COHSM__LANE_COUNT <= pixels; p += COHSM__LANE_COUNT) {
        const cohsm__intervals i = cohsm__intervals_of(n, z + 2 * (size_t)p);
        const cohsm__lane_ints before = cohsm__ints_load(span + p);
        const cohsm__lane_ints lo = cohsm__ints_max(cohsm__ints_and(before, low_half),
                                                    cohsm__grid_above_lanes(i.lo, n->top));
        const cohsm__lane_ints hi = cohsm__ints_min(cohsm__ints_shift_right(before, 16),
                                                    cohsm__grid_below_lanes(i.hi, n->top));
        const cohsm__lane_mask ends = cohsm__ints_greater(lo, hi);
        const cohsm__lane_ints after = cohsm__ints_or(lo, cohsm__ints_mul(hi, cohsm__ints_all(65536)));
        const uint32_t go_on = ~cohsm__mask_bits(ends);
        cohsm__ints_store(span + p, cohsm__ints_select(ends, before, after));
        n->empty += cohsm__bit_count(cohsm__mask_bits(i.empty) & go_on);
        n->open += cohsm__bit_count(cohsm__mask_bits(i.open) & go_on);
        cohsm__ints_append(left + count, ends,
                           cohsm__ints_add(cohsm__ints_load(cohsm__numbers), cohsm__ints_all((int32_t)p)));
        count += cohsm__mask_count(ends);
    }
    for (; p < pixels; p++) left[count++] = (int32_t)p;
    return count;
}

/* ==== src/csm/kernels_trays.h ==== */

/* ---- kernels of query: depths of many trays ---- */

/* Finds the depths of up to a tile of pixels in the fast layout, by loops that each prefetch what the next
   one reads. No branch depends on data but that of exact depths, which few views have. Queries are faster by
   6 to 10 % than a step at a time, since prefetched lines have longer to come. */
COHSM__KERNEL static void cohsm__tray_depths(const cohsm_maps *m, const uint32_t *pixel,
                                             const uint32_t *place, uint32_t count, int32_t *depth)
{
    const cohsm__trays t = m->trays;
    const uint8_t *tray[COHSM__TILE];
    size_t index[COHSM__TILE];
    uint32_t i;

    for (i = 0; i < count; i++) {
        const uint32_t inside = 0u - (uint32_t)(pixel[i] != COHSM__NO_PIXEL);
        index[i] = (size_t)(place[i] >> COHSM__BUCKET_BITS) * m->range + (pixel[i] & inside);
        COHSM__PREFETCH(t.at + index[i]);
    }
    for (i = 0; i < count; i++) {
        const uint32_t at = t.at[index[i]], split = at >> 14;
        const uint32_t inside = 0u - (uint32_t)(pixel[i] != COHSM__NO_PIXEL);
        const uint32_t part = (place[i] & (COHSM__BUCKET - 1u)) >> (COHSM__BUCKET_BITS - split);
        const size_t group = (pixel[i] & inside) >> COHSM__GROUP_BITS;
        const size_t line = t.base[(place[i] >> COHSM__BUCKET_BITS) * t.groups + group];
        const uint32_t shift = 1u + (5u & (0u - (uint32_t)(split > 0)));
        tray[i] = t.lines + COHSM__LINE_BYTES * (line + part) + ((at & 0x3fffu) << shift);
        COHSM__PREFETCH(tray[i]);
    }
    for (i = 0; i < count; i++) {
        const uint32_t view = place[i] & (COHSM__BUCKET - 1u), n = *tray[i];
        const uint32_t at = (uint32_t)((uintptr_t)tray[i] % COHSM__LINE_BYTES) + 1u;
        const uint32_t from = at < 32u ? at : 32u;
        const uint8_t *half = tray[i] + 1 - (at - from);
        const uint32_t j = cohsm__bytes_up_to(half, at - from, n, view), code = tray[i][1u + n + j];
        uint32_t found = m->depth_of[code];
        if (code == COHSM__EXACT_CODE) found = cohsm__tray_exact(tray[i], j, view);
        depth[i] = (int32_t)(found | (COHSM__INFINITE & (0u - (uint32_t)(pixel[i] == COHSM__NO_PIXEL))));
    }
}

/* ==== src/csm/kernels_lists.h ==== */

/* ---- kernels of query: depths of many lists ---- */

/* Does what cohsm__list_block does, and prefetches the block. */
static inline COHSM__IN_KERNEL void cohsm__find_block(cohsm__found *f, const uint32_t *lines)
{
    const uint32_t *directory = f->at;
    const uint32_t where = directory[1], rest = (where & 0xffffu) - 1u;
    const uint32_t count = cohsm__halves_up_to(directory + 2, rest, f->view);
    const uint32_t tail = 0u - (uint32_t)(count == rest);
    const uint32_t line = directory[0] + (count & ~tail) - (where >> 20 & tail);
    f->view -= cohsm__half_word(directory, count + 3u) & (0u - (uint32_t)(count > 0));
    f->at = lines + COHSM__BLOCK_WORDS * (size_t)line + (where >> 16 & 15u & tail);
    COHSM__PREFETCH(f->at);
}

/* Does what cohsm__depth_in_block does. */
static inline COHSM__IN_KERNEL uint32_t cohsm__found_depth(const cohsm__found *f, const uint16_t *depth_of)
{
    const uint64_t marks = cohsm__marks(f->at);
    const uint32_t bucket = f->view >> (f->at[0] >> 8 & 15u);
    const uint32_t at = bucket ? cohsm__nth_bit(~marks, bucket - 1u) + 1u : 0u;
    return cohsm__block_depth(f->at, depth_of, cohsm__bit_count(marks),
                              cohsm__segment_at(f->at, marks, f->view, at));
}

/* Finds the stored depths of up to a step of pixels, in loops that each prefetch what the next one reads. */
COHSM__KERNEL static void cohsm__find_depths(const cohsm_maps *m, const uint32_t *pixel,
                                             const uint32_t *place, uint32_t count, int32_t *depth)
{
    cohsm__found found[COHSM__STEP + 1];
    uint32_t n = 0, i;

#ifndef COHSM_WITHOUT_FAST
    if (m->trays.lines) {
        cohsm__tray_depths(m, pixel, place, count, depth);
        return;
    }
#endif
    for (i = 0; i < count; i++) {
        const uint32_t inside = pixel[i] != COHSM__NO_PIXEL;
        const uint32_t *lookup = m->lookup + (size_t)(place[i] >> COHSM__CHUNK_BITS) * m->range;
        const uint32_t entry = lookup[pixel[i] & (0u - inside)];
        const uint32_t listed = inside & (uint32_t)!(entry & COHSM__CONSTANT);
        depth[i] = inside ? (int32_t)(entry & 0xffffu) : COHSM__INFINITE;       /* nothing is deeper */
        found[n].at = m->directories + (entry & (0u - listed));
        found[n].view = place[i] & (COHSM__CHUNK - 1u);
        found[n].sample = i;
        COHSM__PREFETCH(found[n].at);
        n += listed;
    }
    for (i = 0; i < n; i++) cohsm__find_block(&found[i], m->lines);
    for (i = 0; i < n; i++) depth[found[i].sample] = (int32_t)cohsm__found_depth(&found[i], m->depth_of);
}

#if COHSM__LANE_COUNT == 8
/* Makes the samples of the tile dark that lie deeper than what is stored. */
COHSM__KERNEL static void cohsm__search_tile(cohsm__tile *t)
{
    int32_t stored[COHSM__TILE];
    const uint32_t step = t->maps->trays.lines ? (uint32_t)COHSM__TILE : (uint32_t)COHSM__STEP;
    uint32_t i, k, n;

    for (i = 0; i < t->count; i += n) {
        n = cohsm__min_u32(step, (uint32_t)t->count - i);
        cohsm__find_depths(t->maps, t->pixel + i, t->place + i, n, stored);
        for (k = n; k % COHSM__LANE_COUNT; k++) stored[k] = COHSM__INFINITE;
        for (k = 0; k < n; k += COHSM__LANE_COUNT) {
            const cohsm__lane_mask dark = cohsm__ints_greater(cohsm__ints_load(t->depth + i + k),
                                                              cohsm__ints_load(stored + k));
            const cohsm__lanes visible = cohsm__lanes_load(t->visible + i + k);
            cohsm__lanes_store(t->visible + i + k,
                               cohsm__lanes_select(dark, cohsm__lanes_all(0.0f), visible));
        }
    }
}

/* Loads vectors of the query as (v - center) scale, as long as the samples of all lanes are neighbours in the
   query, which is so for all but the last few of a batch. Returns how many were loaded. */
COHSM__KERNEL static size_t cohsm__load_vectors(const cohsm__tile *t, const float *packed, cohsm__v3 center,
                                                float scale, float (*out)[COHSM__TILE])
{
    const cohsm__lanes3 c = cohsm__lanes3_all(center.x, center.y, center.z);
    const size_t last = COHSM__LANE_COUNT - 1;
    size_t i;

    for (i = 0; i + last < t->count && t->id[i + last] == t->id[i] + last; i += COHSM__LANE_COUNT) {
        const cohsm__lanes3 v = cohsm__lanes3_scale(
            cohsm__lanes3_sub(cohsm__lanes3_load_packed(packed + 3 * t->id[i]), c), cohsm__lanes_all(scale));
        cohsm__lanes_store(out[0] + i, v.x);
        cohsm__lanes_store(out[1] + i, v.y);
        cohsm__lanes_store(out[2] + i, v.z);
    }
    return i;
}
#endif

/* ==== src/csm/kernels_directions.h ==== */

/* ---- kernels of query: directions to latitude-longitude maps, in steps ---- */

#if COHSM__LANE_COUNT == 8

/* Takes square roots by lanes: sqrtf may set errno, so that compilers do not vectorise it. */
static inline COHSM__IN_KERNEL void cohsm__step_roots(float *x)
{
    int k;
    for (k = 0; k < COHSM__STEP; k += COHSM__LANE_COUNT)
        cohsm__lanes_store(x + k, cohsm__lanes_sqrt(cohsm__lanes_load(x + k)));
}

/* Finds where a step's lights lie in the domain, and the cells below, which may be one step outside. */
static inline COHSM__IN_KERNEL void cohsm__step_lights(cohsm__step *s, const cohsm__tile *t, size_t first)
{
    const float *x = t->light[0] + first, *y = t->light[1] + first, *z = t->light[2] + first;
    float top0 = (float)t->maps->head.side[0], top1 = (float)t->maps->head.side[1], u, v;
    float height[COHSM__STEP], root[COHSM__STEP];
    int32_t c0, c1;
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
        s->cell[0][k] = c0 - ((float)c0 > u);
        s->cell[1][k] = c1 - ((float)c1 > v);
    }
}

/* Does what cohsm__wrap_cell does. */
static inline COHSM__IN_KERNEL void cohsm__step_wrap(cohsm__step *s, const cohsm_maps *m)
{
    int32_t n0 = (int32_t)m->head.side[0], n1 = (int32_t)m->head.side[1], c0, c1;
    int k;

    for (k = 0; k < COHSM__STEP; k++) {
        c0 = s->cell[0][k];
        c1 = s->cell[1][k];
        c0 += n0 / 2 & (0 - ((c1 < 0) | (c1 >= n1)));
        c0 += n0 & (0 - (c0 < 0));
        c0 -= n0 & (0 - (c0 >= n0));
        s->cell[0][k] = c0;
        s->cell[1][k] = c1 + (c1 < 0) - (c1 >= n1);
    }
}

/* Does what cohsm__cell_axes does. */
static inline COHSM__IN_KERNEL void cohsm__step_axes(cohsm__step *s, const cohsm_maps *m)
{
    const float *columns = m->angles, *rows = m->angles + 2 * m->head.side[0];
    int k, two_poles = m->head.orientation == COHSM_ORIENTATION_TWO_POLES;

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
    if (m->head.orientation == COHSM_ORIENTATION_POLAR) return;
    for (k = 0; k < COHSM__STEP; k++) {
        float x = s->back[0][k], y = s->back[1][k], z = s->back[2][k];
        float a, g, odd;
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

/* Does what cohsm__project_point does, and moves the samples. */
static inline COHSM__IN_KERNEL void cohsm__step_project(cohsm__step *s, const cohsm__tile *t, size_t first)
{
    const float *px = t->point[0] + first, *py = t->point[1] + first, *pz = t->point[2] + first;
    float top = (float)t->maps->head.map_side, half = 0.5f * top, bias = t->query->bias / top;
    float x, y, d;
    int k;

    for (k = 0; k < COHSM__STEP; k++) {
        x = (px[k] * s->right[0][k] + py[k] * s->right[1][k] + pz[k] * s->right[2][k]) * half + half;
        y = (px[k] * s->up[0][k] + py[k] * s->up[1][k] + pz[k] * s->up[2][k]) * half + half;
        d = px[k] * s->back[0][k] + py[k] * s->back[1][k] + pz[k] * s->back[2][k];
        s->depth[k] = (0.5f - 0.5f * d - bias) * (float)COHSM__HIT_MAX;
        s->at[2][k] = x + (s->jitter[3][k] - 0.5f);
        s->at[3][k] = y + (s->jitter[4][k] - 0.5f);
    }
}

/* Does what cohsm__pixel and cohsm__compared_depth do. Points outside the map, in front of it or not finite
   get COHSM__NO_PIXEL. */
static inline COHSM__IN_KERNEL void cohsm__step_pixels(const cohsm__step *s, cohsm__tile *t, size_t first)
{
    const cohsm_maps *m = t->maps;
    float top = (float)m->head.map_side, x, y, d;
    int32_t side = (int32_t)m->head.map_side, in, p;
    int32_t begin = (int32_t)m->head.pixel_begin, end = begin + (int32_t)m->range;
    int k;

    for (k = 0; k < COHSM__STEP; k++) {
        x = s->at[2][k];
        y = s->at[3][k];
        d = s->depth[k];
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

static inline COHSM__IN_KERNEL void cohsm__step_places(const cohsm__step *s, cohsm__tile *t, size_t first)
{
    const cohsm_maps *m = t->maps;
    uint32_t *place = t->place + first;
    uint32_t n0 = m->head.side[0], n1 = m->head.side[1], c0, c1;
    int k;

    if (m->head.order == COHSM_ORDER_HILBERT)
        for (k = 0; k < COHSM__STEP; k++)
            place[k] = cohsm__place_of_cell(m, (uint32_t)s->cell[0][k], (uint32_t)s->cell[1][k], 0);
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

/* Moves samples as their filter wants. NEAREST takes the cell and the pixel that a sample lies in; ROULETTE
   takes those that hold the sample after it was moved at random by up to half a step; PCF takes the lowest of
   sixteen, and adds the steps from there. */
static inline COHSM__IN_KERNEL void cohsm__step_jitter(cohsm__step *s, const cohsm__tile *t, size_t first)
{
    static const uint32_t dimension[4] = { 0, 1, 3, 4 };
    cohsm_filter filter = t->query->filter;
    uint32_t i, d;
    int k;

    for (i = 0; i < 4; i++) {
        d = dimension[i];
        if (filter == COHSM_FILTER_ROULETTE)
            for (k = 0; k < COHSM__STEP; k++)
                s->jitter[d][k] = cohsm__random(t->seed, (uint32_t)t->id[first + (size_t)k], d);
        else for (k = 0; k < COHSM__STEP; k++) s->jitter[d][k] = filter == COHSM_FILTER_PCF ? 0.0f : 0.5f;
    }
}

/* Finds cell, pixel and depth of every sample of a tile. */
COHSM__KERNEL COHSM__FLATTEN static void cohsm__address_latlong(cohsm__tile *t)
{
    cohsm__step s;
    size_t first;

    for (first = 0; first < t->count; first += COHSM__STEP) {
        cohsm__step_jitter(&s, t, first);
        cohsm__step_lights(&s, t, first);
        cohsm__step_wrap(&s, t->maps);
        cohsm__step_axes(&s, t->maps);
        cohsm__step_project(&s, t, first);
        cohsm__step_pixels(&s, t, first);
        cohsm__step_places(&s, t, first);
    }
}

#ifndef COHSM_WITHOUT_SIMD
/* Keeps two coordinates of a step, cells of the domain or pixels, as fractions of PCF: the lower one, and how
   far the samples lie towards the next. There are at most 4096 cells or pixels: what is far outside may lie
   anywhere outside. */
static inline COHSM__IN_KERNEL void cohsm__step_fractions(float (*at)[COHSM__STEP], size_t first,
                                                          int16_t (*low)[COHSM__TILE],
                                                          float (*weight)[COHSM__TILE])
{
    float x;
    int32_t l;
    int i, k;

    for (i = 0; i < 2; i++)
        for (k = 0; k < COHSM__STEP; k++) {
            x = cohsm__either(fabsf(at[i][k]) < 8192.0f, at[i][k], -9.0f);
            l = (int32_t)x;
            l -= (float)l > x;
            low[i][first + (size_t)k] = (int16_t)l;
            weight[i][first + (size_t)k] = x - (float)l;
        }
}

/* For PCF: the cells below the lights of a tile, once for the four maps around each. */
COHSM__KERNEL COHSM__FLATTEN static void cohsm__cells_latlong(cohsm__tile *t)
{
    cohsm__fractions *f = &t->work.fractions;
    cohsm__step s;
    size_t first, k;

    for (first = 0; first < t->count; first += COHSM__STEP) {
        cohsm__step_jitter(&s, t, first);
        cohsm__step_lights(&s, t, first);
        cohsm__step_fractions(s.at, first, f->cell, f->weight);
        for (k = 0; k < COHSM__STEP; k++) f->valid[first + k] = (uint8_t)s.valid[k];
    }
}

/* For PCF: places and depths in one of the four maps around each light, whose bits 0 and 1 choose the cell,
   and the pixels below, once for the four around each sample. Samples without an answer get a depth of -1. */
COHSM__KERNEL COHSM__FLATTEN static void cohsm__project_latlong(cohsm__tile *t, uint32_t map)
{
    cohsm__fractions *f = &t->work.fractions;
    cohsm__step s;
    size_t first, k;
    float d;

    for (first = 0; first < t->count; first += COHSM__STEP) {
        for (k = 0; k < COHSM__STEP; k++) {
            s.cell[0][k] = f->cell[0][first + k] + (int32_t)(map & 1u);
            s.cell[1][k] = f->cell[1][first + k] + (int32_t)(map >> 1);
            s.jitter[3][k] = s.jitter[4][k] = 0.0f;
        }
        cohsm__step_wrap(&s, t->maps);
        cohsm__step_axes(&s, t->maps);
        cohsm__step_project(&s, t, first);
        cohsm__step_places(&s, t, first);
        cohsm__step_fractions(s.at + 2, first, f->pixel, f->weight + 2);
        for (k = 0; k < COHSM__STEP; k++) {
            d = cohsm__either((f->valid[first + k] != 0) & (s.depth[k] >= 0.0f), s.depth[k], -1.0f);
            t->depth[first + k] = (int32_t)(d < 65535.0f ? d : 65535.0f);
        }
    }
}

/* For PCF: one of the four pixels around each sample, which bits 0 and 1 of the corner choose. */
COHSM__KERNEL static void cohsm__corner_latlong(cohsm__tile *t, uint32_t corner)
{
    const cohsm__fractions *f = &t->work.fractions;
    const uint32_t side = t->maps->head.map_side, begin = t->maps->head.pixel_begin, range = t->maps->range;
    size_t i;

    for (i = 0; i < t->count; i++) {
        const uint32_t x = (uint32_t)(int32_t)f->pixel[0][i] + (corner & 1u);
        const uint32_t y = (uint32_t)(int32_t)f->pixel[1][i] + (corner >> 1);
        const uint32_t p = y * side + x - begin;
        const int in = (x < side) & (y < side) & (p < range) & (t->depth[i] >= 0);
        t->pixel[i] = in ? p : COHSM__NO_PIXEL;
    }
}
#endif

#endif

/* ==== src/csm/kernels_one_light.h ==== */

/* ---- kernels of query: one light for many points ---- */

/* The map that answers for all points of a stream, with each number in all lanes. */
typedef struct cohsm__views {
    cohsm__lanes3 center, right, up, back;      /* the sphere's centre; the axes of the map */
    cohsm__lanes3 eye;                          /* of a cube map */
    cohsm__lanes per_radius, half, top, bias;   /* 1 / radius; M / 2; M; the query's bias, in maps */
    cohsm__lanes nearer, deeper;                /* factors of a cube map's depths: bias, range */
    cohsm__lane_ints side, begin, range;        /* M; the first pixel and the number of pixels of the shard */
} cohsm__views;

static inline COHSM__IN_KERNEL cohsm__views cohsm__views_of(const cohsm__stream *s)
{
    const cohsm__header *h = &s->maps->head;
    const cohsm__axes *f = &s->axes;
    const float top = (float)h->map_side;
    cohsm__views v;
    v.center = cohsm__lanes3_all(h->center[0], h->center[1], h->center[2]);
    v.right = cohsm__lanes3_all(f->right.x, f->right.y, f->right.z);
    v.up = cohsm__lanes3_all(f->up.x, f->up.y, f->up.z);
    v.back = cohsm__lanes3_all(f->back.x, f->back.y, f->back.z);
    v.eye = cohsm__lanes3_all(s->eye.x, s->eye.y, s->eye.z);
    v.per_radius = cohsm__lanes_all(1.0f / h->radius);
    v.half = cohsm__lanes_all(0.5f * top);
    v.top = cohsm__lanes_all(top);
    v.bias = cohsm__lanes_all(s->bias / top);
    v.nearer = cohsm__lanes_all(1.0f - 2.0f * s->bias / top);
    v.deeper = cohsm__lanes_all(h->positional ? h->radius / h->depth_far : 0.0f);
    v.side = cohsm__ints_all((int32_t)h->map_side);
    v.begin = cohsm__ints_all((int32_t)h->pixel_begin);
    v.range = cohsm__ints_all((int32_t)s->maps->range);
    return v;
}

/* Loads vectors, which lie `stride` bytes apart, as many as there are lanes; the last of `count` stands for
   those that are missing. */
static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__load_strided(const void *from, size_t stride,
                                                                 size_t count)
{
    float v[3 * COHSM__LANE_COUNT];
    size_t i;
    if (stride == 12 && count >= COHSM__LANE_COUNT)
        return cohsm__lanes3_load_packed((const float *)from);
    if (stride > 12 && count > COHSM__LANE_COUNT) return cohsm__lanes3_load_fours(from, stride);
    for (i = 0; i < COHSM__LANE_COUNT; i++)
        memcpy(v + 3 * i, (const char *)from + stride * (i < count ? i : count - 1), 12);
    return cohsm__lanes3_load_packed(v);
}

/* Loads the points from number k on, as many as there are lanes, in radii about the centre. */
static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__stream_load(const cohsm__stream *s, const cohsm__views *v,
                                                                size_t k)
{
    const char *from;
    size_t i;

    if (!s->points) return cohsm__lanes3_load(s->x + k, s->y + k, s->z + k);
    from = s->points + s->stride * k;
    if (s->stride <= 64)
        for (i = 0; i < COHSM__LANE_COUNT * s->stride; i += 64) COHSM__PREFETCH(from + COHSM__AHEAD + i);
    return cohsm__lanes3_scale(
        cohsm__lanes3_sub(cohsm__load_strided(from, s->stride, s->count - k), v->center), v->per_radius);
}

/* Points as the maps see them: the position in pixels, the depth in 16 bits; `in` are those that are
   finite; face is the number of the cube's face, where the key has it. */
typedef struct cohsm__seen {
    cohsm__lanes x, y, depth;
    cohsm__lane_ints face;
    cohsm__lane_mask in;
} cohsm__seen;

static inline COHSM__IN_KERNEL cohsm__seen cohsm__see_along_axes(const cohsm__views *v, cohsm__lanes3 p)
{
    const cohsm__lanes middle = cohsm__lanes_all(0.5f);
    cohsm__lanes d = cohsm__lanes_mul(middle, cohsm__lanes3_dot(p, v->back));
    cohsm__seen s;
    s.x = cohsm__lanes_add(cohsm__lanes_mul(cohsm__lanes3_dot(p, v->right), v->half), v->half);
    s.y = cohsm__lanes_add(cohsm__lanes_mul(cohsm__lanes3_dot(p, v->up), v->half), v->half);
    d = cohsm__lanes_sub(cohsm__lanes_sub(middle, d), v->bias);
    s.depth = cohsm__lanes_mul(d, cohsm__lanes_all((float)COHSM__HIT_MAX));
    s.face = cohsm__ints_all(0);
    s.in = cohsm__lanes_at_least(s.depth, cohsm__lanes_all(0.0f));  /* what is not finite is outside anyway */
    return s;
}

/* Rounding may leave the face by a hair. */
static inline COHSM__IN_KERNEL cohsm__lanes cohsm__onto_face(const cohsm__views *v, cohsm__lanes x)
{
    const cohsm__lanes zero = cohsm__lanes_all(0.0f), last = cohsm__lanes_sub(v->top, cohsm__lanes_all(0.5f));
    x = cohsm__lanes_select(cohsm__lanes_greater(zero, x), zero, x);
    return cohsm__lanes_select(cohsm__lanes_at_least(x, v->top), last, x);
}

static inline COHSM__IN_KERNEL cohsm__seen cohsm__see_on_face(const cohsm__views *v, cohsm__lanes3 p)
{
    const cohsm__lanes most = cohsm__lanes_all(3.402823466e38f), zero = cohsm__lanes_all(0.0f);
    const cohsm__lanes3 q = cohsm__lanes3_sub(p, v->eye);
    const cohsm__lanes ax = cohsm__lanes_abs(q.x), ay = cohsm__lanes_abs(q.y), az = cohsm__lanes_abs(q.z);
    const cohsm__lane_mask along_x = cohsm__mask_and(cohsm__lanes_at_least(ax, ay),
                                                     cohsm__lanes_at_least(ax, az));
    const cohsm__lane_mask along_y = cohsm__lanes_at_least(ay, az);
    const cohsm__lanes c = cohsm__lanes_select(along_x, q.x, cohsm__lanes_select(along_y, q.y, q.z));
    const cohsm__lanes w = cohsm__lanes_abs(c);
    const cohsm__lane_ints one = cohsm__ints_all(1 << COHSM__KEY_BITS);
    cohsm__seen s;

    s.face = cohsm__ints_select(along_y, cohsm__ints_all(2 << COHSM__KEY_BITS),
                                cohsm__ints_all(4 << COHSM__KEY_BITS));
    s.face = cohsm__ints_select(along_x, cohsm__ints_all(0), s.face);
    s.face = cohsm__ints_add(s.face, cohsm__ints_keep(cohsm__lanes_greater(zero, c), one));
    s.x = cohsm__lanes_select(along_x, q.y, cohsm__lanes_select(along_y, q.z, q.x));
    s.y = cohsm__lanes_select(along_x, q.z, cohsm__lanes_select(along_y, q.x, q.y));
    s.x = cohsm__lanes_add(cohsm__lanes_mul(cohsm__lanes_div(s.x, w), v->half), v->half);
    s.y = cohsm__lanes_add(cohsm__lanes_mul(cohsm__lanes_div(s.y, w), v->half), v->half);
    s.x = cohsm__onto_face(v, s.x);
    s.y = cohsm__onto_face(v, s.y);
    s.depth = cohsm__lanes_mul(cohsm__lanes_mul(w, v->nearer), v->deeper);
    s.depth = cohsm__lanes_mul(s.depth, cohsm__lanes_all((float)COHSM__HIT_MAX));
    s.in = cohsm__mask_and(cohsm__lanes_at_least(s.depth, zero),
                           cohsm__lanes_at_least(most, cohsm__lanes_abs(p.x)));
    s.in = cohsm__mask_and(s.in, cohsm__mask_and(cohsm__lanes_at_least(most, cohsm__lanes_abs(p.y)),
                                                 cohsm__lanes_at_least(most, cohsm__lanes_abs(p.z))));
    return s;
}

/* Does what cohsm__project_point, cohsm__pixel and cohsm__compared_depth do, for the points from number k on.
   Returns the keys. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__stream_project(cohsm__stream *s, const cohsm__views *v,
                                                                      size_t k)
{
    const cohsm__lanes3 p = cohsm__stream_load(s, v, k);
    const cohsm__seen seen =
        s->maps->head.positional ? cohsm__see_on_face(v, p) : cohsm__see_along_axes(v, p);
    const cohsm__lanes zero = cohsm__lanes_all(0.0f);
    const cohsm__lane_ints none = cohsm__ints_all(-1);
    cohsm__lanes d;
    cohsm__lane_ints pixel;
    cohsm__lane_mask in;

    in = cohsm__mask_and(cohsm__lanes_at_least(seen.x, zero), cohsm__lanes_greater(v->top, seen.x));
    in = cohsm__mask_and(in, cohsm__mask_and(cohsm__lanes_at_least(seen.y, zero),
                                             cohsm__lanes_greater(v->top, seen.y)));
    in = cohsm__mask_and(in, seen.in);
    pixel = cohsm__ints_mul(cohsm__lanes_truncate(cohsm__lanes_keep(in, seen.y)), v->side);
    pixel = cohsm__ints_add(pixel, cohsm__lanes_truncate(cohsm__lanes_keep(in, seen.x)));
    pixel = cohsm__ints_sub(pixel, v->begin);
    in = cohsm__mask_and(in, cohsm__ints_greater(pixel, none));
    in = cohsm__mask_and(in, cohsm__ints_greater(v->range, pixel));
    pixel = cohsm__ints_select(in, cohsm__ints_add(pixel, seen.face), none);
    d = cohsm__lanes_keep(in, cohsm__lanes_min(seen.depth, cohsm__lanes_all(65535.0f)));
    cohsm__ints_store(s->key + k, pixel);
    cohsm__ints_store(s->depth + k, cohsm__lanes_truncate(d));
    return pixel;
}

/* Does what cohsm__slot does. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__slots(cohsm__lane_ints key)
{
    const cohsm__lane_ints high = cohsm__ints_and(cohsm__ints_shift_right(key, 3), cohsm__ints_all(0x1f0));
    return cohsm__ints_or(high, cohsm__ints_and(key, cohsm__ints_all(15)));
}

/* Finds the key and the compared depth of every point. A key whose slot holds another one takes the slot and
   joins the list of those to be decoded, unless the slot was taken by a key of the list already: such a slot
   has the depth -1. */
static inline COHSM__IN_KERNEL void cohsm__stream_find(cohsm__stream *s)
{
    const cohsm__views v = cohsm__views_of(s);
    const cohsm__lane_ints none = cohsm__ints_all(-1);
    cohsm__kept *kept = s->kept;
    size_t k;

    s->listed = 0;
    for (k = 0; k < s->count; k += COHSM__LANE_COUNT) {
        const cohsm__lane_ints key = cohsm__stream_project(s, &v, k);
        const cohsm__lane_mask held =
            cohsm__ints_equal(cohsm__ints_gather(kept->key, cohsm__slots(key)), key);
        uint32_t missed =
            cohsm__mask_bits(cohsm__mask_or(held, cohsm__ints_equal(key, none))) ^ COHSM__ALL_LANES;
        for (; missed; missed &= missed - 1u) {
            const int32_t wanted = s->key[k + cohsm__first_bit(missed)];
            const uint32_t slot = cohsm__slot((uint32_t)wanted);
            if (kept->depth[slot] < 0) continue;
            kept->key[slot] = wanted;
            kept->depth[slot] = -1;
            s->list[s->listed++] = (uint32_t)wanted;
        }
    }
}

/* Decodes the depths of up to a step of keys; those behind the last are read as far as lanes go. */
static inline COHSM__IN_KERNEL void cohsm__keys_decode(const cohsm__stream *s, const uint32_t *key,
                                                       uint32_t count, int32_t *depth)
{
    const cohsm__lane_ints low = cohsm__ints_all((1 << COHSM__KEY_BITS) - 1);
    const cohsm__lane_ints first = cohsm__ints_all((int32_t)s->place);
    const cohsm__lane_ints maps = cohsm__ints_all((int32_t)s->maps->head.map_count);
    uint32_t k;
    int32_t pixel[COHSM__STEP], place[COHSM__STEP];

    for (k = 0; k < count; k += COHSM__LANE_COUNT) {
        const cohsm__lane_ints all = cohsm__ints_load((const int32_t *)(const void *)(key + k));
        const cohsm__lane_ints face = cohsm__ints_shift_right(all, COHSM__KEY_BITS);
        cohsm__ints_store(pixel + k, cohsm__ints_and(all, low));
        cohsm__ints_store(place + k, cohsm__ints_add(first, cohsm__ints_mul(face, maps)));
    }
    cohsm__find_depths(s->maps, (const uint32_t *)pixel, (const uint32_t *)place, count, depth);
}

static inline COHSM__IN_KERNEL void cohsm__stream_decode(cohsm__stream *s)
{
    uint32_t i, k, n;
    int32_t depth[COHSM__STEP];

    for (i = 0; i < s->listed; i += n) {
        n = cohsm__min_u32(s->listed - i, COHSM__STEP);
        cohsm__keys_decode(s, s->list + i, n, depth);
        for (k = 0; k < n; k++) s->kept->depth[cohsm__slot(s->list[i + k])] = depth[k];
    }
}

/* Writes the answers of points whose keys have a slot, and lists the others. */
static inline COHSM__IN_KERNEL void cohsm__stream_compare(cohsm__stream *s, float *visible)
{
    const cohsm__lane_ints one = cohsm__ints_all(1), none = cohsm__ints_all(-1);
    float last[COHSM__LANE_COUNT];
    uint32_t taken;
    size_t k;

    s->listed = 0;
    for (k = 0; k < s->count; k += COHSM__LANE_COUNT) {
        const size_t left = s->count - k;
        const cohsm__lane_ints key = cohsm__ints_load(s->key + k), slot = cohsm__slots(key);
        const cohsm__lane_ints known = cohsm__ints_gather(s->kept->depth, slot);
        const cohsm__lane_mask out = cohsm__ints_equal(key, none);
        const cohsm__lane_mask lit =
            cohsm__ints_greater(cohsm__ints_add(known, one), cohsm__ints_load(s->depth + k));
        const cohsm__lane_mask held = cohsm__ints_equal(cohsm__ints_gather(s->kept->key, slot), key);
        const cohsm__lanes answer = cohsm__lanes_keep(cohsm__mask_or(out, lit), cohsm__lanes_all(1.0f));
        taken = cohsm__mask_bits(cohsm__mask_or(out, held)) ^ COHSM__ALL_LANES;
        if (left >= COHSM__LANE_COUNT) cohsm__lanes_store(visible + k, answer);
        else {
            cohsm__lanes_store(last, answer);
            memcpy(visible + k, last, left * sizeof *last);
            taken &= (1u << left) - 1u;
        }
        for (; taken; taken &= taken - 1u) s->list[s->listed++] = (uint32_t)k + cohsm__first_bit(taken);
    }
}

/* Decodes and answers for the points that are listed. */
static inline COHSM__IN_KERNEL void cohsm__stream_rest(const cohsm__stream *s, float *visible)
{
    uint32_t key[COHSM__STEP] = { 0 }, i, k, n;
    int32_t depth[COHSM__STEP];

    for (i = 0; i < s->listed; i += n) {
        const uint32_t *at = s->list + i;
        n = cohsm__min_u32(s->listed - i, COHSM__STEP);
        for (k = 0; k < n; k++) key[k] = (uint32_t)s->key[at[k]];
        cohsm__keys_decode(s, key, n, depth);
        for (k = 0; k < n; k++) visible[at[k]] = s->depth[at[k]] > depth[k] ? 0.0f : 1.0f;
    }
}

/* Answers for the points of the stream. */
COHSM__KERNEL static void cohsm__one_light(cohsm__stream *s, float *visible)
{
    cohsm__stream_find(s);
    cohsm__stream_decode(s);
    cohsm__stream_compare(s, visible);
    cohsm__stream_rest(s, visible);
}

/* ==== src/csm/kernels_scene.h ==== */

/* ---- kernels of query: which instances a sample's ray meets ---- */

/* Rays of samples: from points along directions up to `reach`. Points lie up to `slack` off, as far as
   rounding takes them on their way to an object's space. Directions are longer than 1 by more than rounding
   takes from distances, which so come out too short. */
typedef struct cohsm__rays { cohsm__lanes3 point, direction; cohsm__lanes reach, slack; } cohsm__rays;

static inline COHSM__IN_KERNEL cohsm__rays cohsm__load_rays(const cohsm_query *q, size_t first, size_t count)
{
    const size_t point = q->position_stride ? q->position_stride : 12;
    const size_t light = q->light_stride ? q->light_stride : 12;
    const size_t from = q->one_light ? 0 : first;
    cohsm__rays r;
    cohsm__lanes length;
    r.point = cohsm__load_strided((const char *)(const void *)q->positions + point * first, point, count);
    r.direction = cohsm__load_strided((const char *)q->lights + light * from, q->one_light ? 0 : light,
                                      count);
    if (q->light_kind == COHSM_LIGHT_POSITION) r.direction = cohsm__lanes3_sub(r.direction, r.point);
    length = cohsm__lanes_sqrt(cohsm__lanes3_dot(r.direction, r.direction));
    r.reach = length;
    r.direction = cohsm__lanes3_scale(r.direction, cohsm__lanes_div(cohsm__lanes_all(1.000001f), length));
    length = cohsm__lanes_add(cohsm__lanes_abs(r.point.x), cohsm__lanes_abs(r.point.y));
    length = cohsm__lanes_add(length, cohsm__lanes_abs(r.point.z));
    r.slack = cohsm__lanes_mul(length, cohsm__lanes_all(COHSM__SLACK));
    return r;
}

/* Returns the lanes whose segments miss a sphere: the nearest point of each lies outside. */
static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__segments_miss(const cohsm__rays *r, cohsm__lanes along,
                                                                     cohsm__lanes square, cohsm__lanes radius)
{
    const cohsm__lanes t = cohsm__lanes_min(cohsm__lanes_max(along, cohsm__lanes_all(0.0f)), r->reach);
    const cohsm__lanes w = cohsm__lanes_mul(t, cohsm__lanes_sub(t, cohsm__lanes_add(along, along)));
    return cohsm__lanes_greater(cohsm__lanes_add(w, square), cohsm__lanes_mul(radius, radius));
}

/* Returns the lanes whose cones miss a sphere of radius r: all of the sphere lies behind the apex, or, with
   the centre at the distance `along` on the axis and at p from it, p cos a - along sin a > r. */
static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__cones_miss(const cohsm__sphere *s, cohsm__lanes along,
                                                                  cohsm__lanes square, cohsm__lanes slack)
{
    const cohsm__lanes radius = cohsm__lanes_add(cohsm__lanes_all(s->radius), slack);
    const cohsm__lanes behind = cohsm__lanes_add(along, radius);
    cohsm__lanes limit = cohsm__lanes_add(cohsm__lanes_all(s->cone_radius), cohsm__lanes_add(slack, slack));
    limit = cohsm__lanes_muladd(along, cohsm__lanes_all(s->slope), limit);
    square = cohsm__lanes_sub(square, cohsm__lanes_mul(along, along));
    return cohsm__mask_or(cohsm__lanes_greater(cohsm__lanes_all(0.0f), behind),
                          cohsm__lanes_greater(square, cohsm__lanes_mul(limit, limit)));
}

/* Sets a bit for each sample from number `first` on and each sphere if the sample's ray may meet the sphere.
   Comparisons with what is not a number are false, so that such a sample asks. */
COHSM__KERNEL static void cohsm__meet_spheres(const cohsm_query *q, size_t first, size_t count,
                                              cohsm__bunch *b)
{
    size_t k;
    uint32_t j;
    for (k = 0; k < count; k += COHSM__LANE_COUNT) {
        const cohsm__rays r = cohsm__load_rays(q, first + k, count - k);
        for (j = 0; j < b->count; j++) {
            const cohsm__sphere *s = &b->sphere[j];
            const cohsm__lanes3 v = cohsm__lanes3_sub(cohsm__lanes3_all(s->x, s->y, s->z), r.point);
            const cohsm__lanes square = cohsm__lanes3_dot(v, v), along = cohsm__lanes3_dot(v, r.direction);
            cohsm__lane_mask miss;
            if (q->light_kind == COHSM_LIGHT_POSITION)
                miss = cohsm__segments_miss(&r, along, square,
                                            cohsm__lanes_add(cohsm__lanes_all(s->radius), r.slack));
            else miss = cohsm__cones_miss(s, along, square, r.slack);
            b->asked[j][k / 32] |= (cohsm__mask_bits(miss) ^ COHSM__ALL_LANES) << k % 32;
        }
    }
}

/* ==== src/csm/kernels_end.h ==== */

#undef COHSM__SET
#undef COHSM__WIDTH
#undef COHSM__LANE_COUNT
#endif /* COHSM__SET */

#if defined(CSM_IMPLEMENTATION) && !defined(CSM_IMPLEMENTED)
#define CSM_IMPLEMENTED

/* ==== src/csm/kernels_sets.h ==== */

/* ---- kernels: those of AVX2 and AVX-512 ---- */

#if COHSM__SIMD_SETS
#define COHSM__SET avx2
#define COHSM__WIDTH 8
#define COHSM__LANE_COUNT 8
#include COHSM__FILE
#define COHSM__SET avx512
#define COHSM__WIDTH 16
#define COHSM__LANE_COUNT 16
#include COHSM__FILE
#endif

/* ==== src/csm/kernels_choose.h ==== */

/* ---- kernels: which to call ---- */

typedef struct cohsm__kernels {
    void (*address)(cohsm__tile *t);
#ifndef COHSM_WITHOUT_SIMD
    void (*cells)(cohsm__tile *t);
    void (*project)(cohsm__tile *t, uint32_t map);
    void (*corner)(cohsm__tile *t, uint32_t corner);
#endif
    void (*search)(cohsm__tile *t);
    size_t (*load_vectors)(const cohsm__tile *t, const float *packed, cohsm__v3 center, float scale,
                           float (*out)[COHSM__TILE]);
    void (*one_light)(cohsm__stream *s, float *visible);
    void (*meet_spheres)(const cohsm_query *q, size_t first, size_t count, cohsm__bunch *b);
#ifndef COHSM_WITHOUT_BUILD
    void (*find)(const cohsm__target *t, cohsm__v3 up, const cohsm__soup *soup, uint32_t begin, uint32_t end,
                 cohsm__sight *sight);
    void (*find_slab)(const cohsm__target *t, const cohsm__camera *cam, const cohsm__soup *soup,
                      const cohsm__sight *sight, uint32_t first, cohsm__slab *slab);
    void (*enqueue_slab)(const cohsm__target *t, const cohsm__camera *cam, const cohsm__slab *slab,
                          cohsm__queue *q);
    void (*draw_queue)(const cohsm__target *t, const cohsm__camera *cam, cohsm__queue *q, int all);
    uint32_t (*narrow)(cohsm__narrowing *n, const uint16_t *z, int32_t *span, uint32_t pixels, int32_t *left);
#endif
} cohsm__kernels;

static cohsm__kernels cohsm__choose_kernels(int simd)
{
    cohsm__kernels k;
    k.address = cohsm__address_latlong_plain;
#ifndef COHSM_WITHOUT_SIMD
    k.cells = cohsm__cells_latlong_plain;
    k.project = cohsm__project_latlong_plain;
    k.corner = cohsm__corner_latlong_plain;
#endif
    k.search = cohsm__search_tile_plain;
    k.load_vectors = cohsm__load_vectors_plain;
    k.one_light = cohsm__one_light_plain;
    k.meet_spheres = cohsm__meet_spheres_plain;
#ifndef COHSM_WITHOUT_BUILD
    k.find = cohsm__find_clusters_plain;
    k.find_slab = cohsm__find_slab_plain;
    k.enqueue_slab = cohsm__enqueue_slab_plain;
    k.draw_queue = cohsm__draw_queue_plain;
    k.narrow = cohsm__narrow_plain;
#endif
#if COHSM__SIMD_SETS
    if (simd) {
        k.address = cohsm__address_latlong_avx2;
        k.cells = cohsm__cells_latlong_avx2;
        k.project = cohsm__project_latlong_avx2;
        k.corner = cohsm__corner_latlong_avx2;
        k.search = cohsm__search_tile_avx2;
        k.load_vectors = cohsm__load_vectors_avx2;
        k.meet_spheres = simd == 2 ? cohsm__meet_spheres_avx512 : cohsm__meet_spheres_avx2;
        k.one_light = simd == 2 ? cohsm__one_light_avx512 : cohsm__one_light_avx2;
#ifndef COHSM_WITHOUT_BUILD
        k.find = cohsm__find_clusters_avx2;
        k.find_slab = simd == 2 ? cohsm__find_slab_avx512 : cohsm__find_slab_avx2;
        k.enqueue_slab = simd == 2 ? cohsm__enqueue_slab_avx512 : cohsm__enqueue_slab_avx2;
        k.draw_queue = simd == 2 ? cohsm__draw_queue_avx512 : cohsm__draw_queue_avx2;
        k.narrow = simd == 2 ? cohsm__narrow_avx512 : cohsm__narrow_avx2;
#endif
    }
#else
    (void)simd;
#endif
    return k;
}

/* ==== src/csm/compress.h ==== */

/* ---- compress: the views of a batch to segments ---- */

/* Adds one pixel of a view to the open segment of that pixel, greedily: a segment goes on as long as one grid
   value separates the layers of all its views (equation 1). No sequence of segments is shorter: any part of a
   segment that can be stored can be stored too, so by induction the greedy segments end no earlier than those
   of any other sequence. A view that no grid value separates is a segment of its own, and stored exactly, in
   every sequence. */
static void cohsm__compress_pixel(cohsm_builder *b, cohsm__range *r, uint32_t p, const uint16_t *z,
                                  uint32_t view)
{
    uint32_t lo, hi, depth;              /* what the view at hand can store */
    uint32_t grid_lo, grid_hi;           /* the same on the grid */
    uint32_t both_lo, both_hi;           /* what the open segment can store with this view in it */

    r->empty += (uint64_t)cohsm__interval(b, z, &lo, &hi);
    r->open += z[0] != COHSM__INFINITE && z[1] == COHSM__INFINITE;
    grid_lo = cohsm__grid_above(lo, b->grid.top);
    grid_hi = cohsm__grid_below(hi, b->grid.top);
    both_lo = cohsm__max_u32(cohsm__span_lo(b->span[p]), grid_lo);
    both_hi = cohsm__min_u32(cohsm__span_hi(b->span[p]), grid_hi);
    if (both_lo > both_hi) {
        if (b->first[p] != view) cohsm__close_open_segment(b, r, p);
        b->first[p] = view;
        both_lo = grid_lo;
        both_hi = grid_hi;
        if (grid_lo > grid_hi) {
            depth = (lo + hi) / 2u;
            cohsm__close_segment(b, r, p, COHSM__EXACT, depth & 255u, depth >> 8);
            r->exact++;
            b->first[p] = view + 1u;
            both_lo = 0;
            both_hi = b->grid.top;
        }
    }
    b->span[p] = cohsm__span_pack(both_lo, both_hi);
}

/* Returns what the kernels need to know of a build, see cohsm__narrowing. */
static cohsm__narrowing cohsm__narrowing_of(const cohsm_builder *b)
{
    cohsm__narrowing n;
    n.top = (int32_t)b->grid.top;
    n.miss = b->desc.self_only ? 0 : (int32_t)COHSM__INFINITE;
    n.slope = b->head.positional ? b->thickness : 0.0f;
    n.gap = b->head.positional ? 0.0f : b->thickness;
    n.empty = n.open = 0;
    return n;
}

/* Adds a view to the segments of a range of pixels. Of nine open segments eight or more go on: kernels narrow
   them together, some hundred pixels at a time, and list the pixels that are left: those whose segment ends,
   and the last few. Kernels take two layers, and read both as one word, the first layer in its low half.
   Returns 0 if it stopped before r->next_pixel for want of a page. */
static int cohsm__compress_view(cohsm_builder *b, cohsm__range *r, const cohsm__kernels *kernels,
                                const uint16_t *z, uint32_t view)
{
    const int together = b->keep == 2 && cohsm__host_is_little_endian();
    cohsm__narrowing n = cohsm__narrowing_of(b);
    int32_t left[COHSM__NARROWED + 16];
    uint32_t i, count, pixels;

    for (; r->next_pixel < r->end; r->next_pixel += pixels) {
        const uint32_t p = r->next_pixel;
        const uint16_t *from = z + (size_t)p * b->keep;
        pixels = cohsm__min_u32((uint32_t)COHSM__NARROWED, r->end - p);
        if (!cohsm__page_ready(b, r, pixels)) break;
        if (together) {
            count = kernels->narrow(&n, from, b->span + p, pixels, left);
            for (i = 0; i < count; i++)
                cohsm__compress_pixel(b, r, p + (uint32_t)left[i], from + 2 * left[i], view);
        } else for (i = 0; i < pixels; i++)
            cohsm__compress_pixel(b, r, p + i, from + (size_t)i * b->keep, view);
    }
    r->empty += n.empty;
    r->open += n.open;
    return r->next_pixel == r->end;
}

static void cohsm__compress_task(void *context, size_t index)
{
    cohsm_builder *b = (cohsm_builder *)context;
    cohsm__range *r = &b->ranges[index];
    const uint32_t chunk_begin = b->batch_begin & ~(COHSM__CHUNK - 1u);
    const uint16_t *z = b->batch + (size_t)b->desc.pixel_begin * b->keep;
    const cohsm__kernels kernels = cohsm__choose_kernels(b->simd);

    if (r->begin == r->end) return;                 /* fewer pixels than ranges */
    for (; r->next_view < b->batch_count; r->next_view++, r->next_pixel = r->begin) {
        r->starved = !cohsm__compress_view(b, r, &kernels, z + (size_t)r->next_view * b->batch_size,
                                           b->batch_begin + r->next_view - chunk_begin);
        if (r->starved) return;
    }
}

static cohsm_result cohsm__compress_batch(cohsm_builder *b)
{
    int i, starved;

    for (i = 0; i < COHSM__RANGES; i++) {
        b->ranges[i].next_view = 0;
        b->ranges[i].next_pixel = b->ranges[i].begin;
    }
    do {
        if (cohsm__take_spares(b) != COHSM_OK) return COHSM_ERR_ALLOC;
        cohsm__run_tasks(&b->desc.system, COHSM__RANGES, cohsm__compress_task, b);
        for (i = 0, starved = 0; i < COHSM__RANGES; i++) starved |= b->ranges[i].starved;
    } while (starved);
    return COHSM_OK;
}


/* ==== src/csm/builder_views.h ==== */

/* ---- builder: made of a desc, given views one by one, and finished ---- */

COHSM_DEF void cohsm_builder_free(cohsm_builder *b)
{
    cohsm__words *w, *next;
    cohsm__counted_heap heap;
    uint32_t n;
    int i;

    if (!b) return;
    n = b->range_pixels;
    for (w = b->lists; w; w = next) {
        next = w->next;
        cohsm__heap_free(&b->heap, w, 1, sizeof *w + 4 * w->count);
    }
    for (i = 0; i < COHSM__RANGES; i++) {
        cohsm__free_pages(b, b->ranges[i].first);
        cohsm__free_pages(b, b->ranges[i].spare);
    }
    cohsm__heap_free(&b->heap, b->batch, (size_t)b->batch_size * b->batch_views, sizeof *b->batch);
    cohsm__heap_free(&b->heap, b->lookup, (size_t)n * cohsm__chunks(&b->head), sizeof *b->lookup);
    cohsm__heap_free(&b->heap, b->first, n, sizeof *b->first);
    cohsm__heap_free(&b->heap, b->span, n, sizeof *b->span);
    cohsm__heap_free(&b->heap, b->angles, 2 * ((size_t)b->head.side[0] + b->head.side[1]), sizeof(float));
    cohsm__heap_free(&b->heap, b->locations, b->head.location_words, sizeof(float));
    cohsm__heap_free(&b->heap, b->cells, b->head.map_count, sizeof *b->cells);
    heap = b->heap;
    cohsm__heap_free(&heap, b, 1, sizeof *b);
}

/* Copies the locations of the desc, and normalises those that are directions. A direction that is unit but
   for rounding stays as it is: the desc of a built block must give the same rays again. */
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

static void cohsm__drop_builder(cohsm_builder *b, cohsm__counted_heap *heap)
{
    heap->peak = b->heap.peak;
    heap->used -= sizeof *b;
    cohsm_builder_free(b);
}

/* Returns how many views a batch has: with threads as many as give each of 16 one column of them. */
static uint32_t cohsm__batch_views(const cohsm_desc *d)
{
    if (d->map_side > (uint32_t)COHSM__BATCH_SIDE) return (uint32_t)COHSM__BATCH / 4u;
    return (uint32_t)COHSM__BATCH / (d->system.parallel_for ? 1u : 2u);
}

/* Makes a builder of a desc that is checked and complete. On success the builder's heap takes over what heap
   had counted. */
static cohsm_result cohsm__builder_make(const cohsm_desc *desc, cohsm__counted_heap *heap,
                                        cohsm_builder **out)
{
    cohsm_builder *b = (cohsm_builder *)cohsm__heap_alloc(heap, 1, sizeof *b);
    uint32_t n = desc->pixel_end - desc->pixel_begin, i;
    size_t lookup;

    if (!b) return COHSM_ERR_ALLOC;
    memset(b, 0, sizeof *b);
    b->desc = *desc;
    cohsm__fill_header(&b->head, desc);
    b->heap = *heap;
    b->range_pixels = n;
    b->simd = cohsm__simd();
    b->grid = cohsm__grid_of(desc->depth_bits, desc->map_side);
    b->thickness = desc->open_thickness * (b->head.positional ? 2.0f : 65536.0f) / (float)desc->map_side;
    b->keep = desc->layers == COHSM_LAYERS_Z1Z2 ? 2 : 4;
    b->batch_size = desc->map_side * desc->map_side * b->keep;
    b->batch_views = cohsm__batch_views(desc);
    if (!cohsm__mul_size(n, cohsm__chunks(&b->head), &lookup) || lookup > UINT32_MAX / 4) {
        cohsm__heap_free(heap, b, 1, sizeof *b);
        return COHSM_ERR_LIMIT;
    }
    b->cells = (uint32_t *)cohsm__heap_alloc(&b->heap, b->head.map_count, sizeof *b->cells);
    b->angles =
        (float *)cohsm__heap_alloc(&b->heap, 2 * ((size_t)b->head.side[0] + b->head.side[1]), sizeof(float));
    if (b->head.location_words)
        b->locations = (float *)cohsm__heap_alloc(&b->heap, b->head.location_words, sizeof(float));
    b->span = (int32_t *)cohsm__heap_alloc(&b->heap, n, sizeof *b->span);
    b->first = (uint32_t *)cohsm__heap_alloc(&b->heap, n, sizeof *b->first);
    b->lookup = (uint32_t *)cohsm__heap_alloc(&b->heap, lookup, sizeof *b->lookup);
    b->batch =
        (uint16_t *)cohsm__heap_alloc(&b->heap, (size_t)b->batch_size * b->batch_views, sizeof *b->batch);
    cohsm__split_ranges(b);
    if (!b->cells || !b->angles || (b->head.location_words && !b->locations) || !b->span ||
        !b->first || !b->lookup || !b->batch) {
        cohsm__drop_builder(b, heap);
        return COHSM_ERR_ALLOC;
    }
    for (i = 0; i < n; i++) b->span[i] = cohsm__span_pack(0, b->grid.top);
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
    cohsm__counted_heap heap;
    cohsm__logger log;
    cohsm_result result;

    if (!desc) return COHSM_ERR_ARGUMENT;
    d = *desc;
    log = cohsm__logger_of(&d.system, "cohsm_builder_create");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    result = cohsm__check_desc(&d, &log);
    if (result != COHSM_OK) return result;
    if (!cohsm__radius_usable(d.radius))
        return cohsm__refuse_value(&log, "desc.radius", (double)d.radius, "above 0, 1e-18..1e18");
    if (d.order == COHSM_ORDER_DEFAULT) d.order = COHSM_ORDER_HILBERT;
    if (d.orientation == COHSM_ORIENTATION_DEFAULT) d.orientation = COHSM_ORIENTATION_POLAR;
    memset(&heap, 0, sizeof heap);
    heap.allocator = cohsm__allocator_of(&d.system);
    return cohsm__log_build(&log, &d, cohsm__builder_make(&d, &heap, out));
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
    float half = 0.5f * (float)h->map_side, scale = half / h->radius;
    cohsm__v3 c = cohsm__v3_load(h->center);
    cohsm__v3 axis[3], x, y, w;
    int i = (int)(cam->face >> 1);

    memset(m, 0, 16 * sizeof *m);
    m[15] = 1.0f;
    if (!cam->perspective) {
        cohsm__put_row(m, 0, cohsm__v3_scale(cam->axes.right, scale),
                       half - scale * cohsm__v3_dot(cam->axes.right, c));
        cohsm__put_row(m, 1, cohsm__v3_scale(cam->axes.up, scale),
                       half - scale * cohsm__v3_dot(cam->axes.up, c));
        cohsm__put_row(m, 2, cohsm__v3_scale(cam->axes.back, -0.5f / h->radius),
                       0.5f + 0.5f / h->radius * cohsm__v3_dot(cam->axes.back, c));
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
    cohsm__logger log;

    if (!b) return COHSM_ERR_ARGUMENT;
    log = cohsm__logger_of(&b->desc.system, "cohsm_builder_view");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (index >= b->head.view_count) {
        cohsm__log_bound(&log, "index", index, "below", b->head.view_count, "the number of views");
        return COHSM_ERR_ARGUMENT;
    }
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

/* Turns the caller's depths into 16-bit layers of the shard's pixels. */
static void cohsm__take_layers(const cohsm_builder *b, uint16_t *z, const float *z1, const float *z2,
                               const float *z3)
{
    const float *layer[3];
    cohsm__camera cam =
        cohsm__camera_of(&b->head, b->locations, b->angles, b->cells[b->next_view % b->head.map_count],
                         b->next_view / b->head.map_count);
    uint32_t p, pixel, i;

    layer[0] = z1;
    layer[1] = z2;
    layer[2] = z3;
    for (p = 0; p < b->range_pixels; p++) {
        pixel = b->desc.pixel_begin + p;
        for (i = 0; i < (b->keep == 4 ? 3u : 2u); i++)
            z[pixel * b->keep + i] =
                layer[i][pixel] <= 1.0f ? cohsm__depth16(layer[i][pixel]) : (uint16_t)COHSM__INFINITE;
        if (b->keep == 4) z[pixel * b->keep + 3] = cohsm__leave_depth(&cam, b->head.map_side, pixel);
    }
}

COHSM_DEF cohsm_result cohsm_builder_add(cohsm_builder *b, uint32_t index, const float *z1, const float *z2,
                                         const float *z3)
{
    uint32_t i, pixels;
    cohsm__logger log;

    if (!b) return COHSM_ERR_ARGUMENT;
    log = cohsm__logger_of(&b->desc.system, "cohsm_builder_add");
    if (!z1) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "z1", "is NULL");
    if (!z2) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "z2", "is NULL");
    if (b->keep == 4 && !z3) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "z3", "is NULL");
    if (b->finished)
        return cohsm__refuse(&log, COHSM_ERR_ORDER, "the builder", "has ended, or failed before");
    if (index >= b->head.view_count) {
        cohsm__log_bound(&log, "index", index, "below", b->head.view_count, "the number of views");
        return COHSM_ERR_ORDER;
    }
    if (index != b->batch_begin + b->batch_count) {
        cohsm__log_value(&log, "index", (double)index, "the number of views that were added before");
        return COHSM_ERR_ORDER;
    }
    pixels = b->head.map_side * b->head.map_side;
    for (i = 0; i < pixels; i++)
        if (!(z1[i] <= z2[i]) || (b->keep == 4 && !(z2[i] <= z3[i]))) {
            cohsm__log_element(&log, z1[i] <= z2[i] ? "z2" : "z1", i, "is",
                               (double)(z1[i] <= z2[i] ? z2[i] : z1[i]),
                               "at most the depth of the next layer there");
            return COHSM_ERR_INPUT;
        }
    b->next_view = index;
    cohsm__take_layers(b, b->batch + (size_t)b->batch_size * b->batch_count, z1, z2, z3);
    b->batch_count++;
    if (b->batch_count < b->batch_views && index + 1 < b->head.view_count) return COHSM_OK;
    return cohsm__log_result(&log, cohsm__close_batch(b));
}

/* ==== src/csm/segments.h ==== */

/* ---- segments: found elsewhere, and written here ---- */

/* While a chunk is taken, b->span holds for each pixel where its last segment begins, or -1. */
static void cohsm__await_segments(cohsm_builder *b)
{
    uint32_t p;
    for (p = 0; p < b->range_pixels; p++) b->span[p] = -1;
}

/* Writes the lists of the chunk that ends before view `end`, after checking that each pixel has a segment. */
static cohsm_result cohsm__end_segments(cohsm_builder *b, uint32_t end, const cohsm__logger *log)
{
    const uint32_t views = ((end - 1u) & (COHSM__CHUNK - 1u)) + 1u;
    cohsm_result result;
    uint32_t p;

    for (p = 0; p < b->range_pixels; p++) {
        if (b->span[p] < 0) {
            cohsm__log_value(log, "the pixel without a segment", (double)(b->desc.pixel_begin + p), "none");
            return COHSM_ERR_INPUT;
        }
        b->first[p] = views;            /* nothing is open */
    }
    b->next_view = end;
    result = cohsm__close_chunk(b);
    cohsm__await_segments(b);
    return result;
}

/* Returns the range of a pixel. */
static cohsm__range *cohsm__range_of(cohsm_builder *b, uint32_t pixel)
{
    uint32_t lo = 0, hi = COHSM__RANGES, middle;
    while (hi - lo > 1u) {
        middle = (lo + hi) / 2u;
        if (b->ranges[middle].begin <= pixel) lo = middle;
        else hi = middle;
    }
    return &b->ranges[lo];
}

/* The segments that are taken, and the number of the one whose turn it is. */
typedef struct cohsm__taking {
    const cohsm_segment *segments;
    size_t               at;
    const cohsm__logger *log;
} cohsm__taking;

static cohsm_result cohsm__refuse_segment(const cohsm__taking *take, const char *what, uint32_t value,
                                          const char *wanted)
{
    cohsm__log_element(take->log, "segments", take->at, what, (double)value, wanted);
    return COHSM_ERR_INPUT;
}

/* Takes one segment, of pixel p of the shard. Returns COHSM_ERR_INPUT if it does not follow the last one. */
static cohsm_result cohsm__take_segment(cohsm_builder *b, const cohsm__taking *take, uint32_t p)
{
    const cohsm_segment *s = &take->segments[take->at];
    const uint32_t first = s->first & (COHSM__CHUNK - 1u), exact = s->value & 65536u;
    const uint32_t lo = s->value & 255u, hi = s->value >> 8 & 255u;
    cohsm__range *r = cohsm__range_of(b, p);

    if (s->value > 131071u || (!exact && (lo > hi || hi > b->grid.top)))
        return cohsm__refuse_segment(take, "has the value", s->value,
                                     "lo | hi << 8 with lo <= hi < 2^depth_bits, or a depth | 1 << 16");
    if (b->span[p] < 0 && first)
        return cohsm__refuse_segment(take, "has the first view", s->first,
                                     "a multiple of 65536, as the first of its pixel");
    if ((int64_t)first <= b->span[p])
        return cohsm__refuse_segment(take, "has the first view", s->first,
                                     "above that of the segment before it of its pixel");
    if (!cohsm__page_ready(b, r, 1)) {
        if (cohsm__take_spares(b) != COHSM_OK) return COHSM_ERR_ALLOC;
        cohsm__page_ready(b, r, 1);
    }
    b->span[p] = (int32_t)first;
    b->first[p] = first;
    cohsm__close_segment(b, r, p, exact ? COHSM__EXACT : 0u, lo, hi);
    r->exact += exact != 0;
    return COHSM_OK;
}

/* Checks what can be told without the other segments of the pixel. */
static cohsm_result cohsm__check_segment(const cohsm_builder *b, const cohsm__taking *take, uint32_t chunk)
{
    const cohsm_segment *s = &take->segments[take->at];
    if (s->pixel >= b->head.map_side * b->head.map_side)
        return cohsm__refuse_segment(take, "has the pixel", s->pixel, "below map_side^2");
    if (s->first >= b->head.view_count)
        return cohsm__refuse_segment(take, "has the first view", s->first, "below the number of views");
    if (s->first >> COHSM__CHUNK_BITS < chunk)
        return cohsm__refuse_segment(take, "has the first view", s->first,
                                     "at or above the multiple of 65536 that others have reached");
    return COHSM_OK;
}

/* Takes all segments in their order, and writes the lists of each chunk when the next one begins. */
static cohsm_result cohsm__take_segments(cohsm_builder *b, cohsm__taking *take, size_t count)
{
    uint32_t chunk = 0;
    cohsm_result result;

    cohsm__await_segments(b);
    for (take->at = 0; take->at < count; take->at++) {
        const cohsm_segment *s = &take->segments[take->at];
        const uint32_t p = s->pixel - b->desc.pixel_begin;
        result = cohsm__check_segment(b, take, chunk);
        while (result == COHSM_OK && s->first >> COHSM__CHUNK_BITS > chunk)
            result = cohsm__end_segments(b, ++chunk << COHSM__CHUNK_BITS, take->log);
        if (result == COHSM_OK && p < b->range_pixels) result = cohsm__take_segment(b, take, p);
        if (result != COHSM_OK) return result;
    }
    return cohsm__end_segments(b, b->head.view_count, take->log);
}

COHSM_DEF cohsm_result cohsm_builder_import(cohsm_builder *b, const cohsm_segment *segments, size_t count)
{
    cohsm__logger log;
    cohsm__taking take;
    cohsm_result result;

    if (!b) return COHSM_ERR_ARGUMENT;
    log = cohsm__logger_of(&b->desc.system, "cohsm_builder_import");
    if (!segments) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "segments", "is NULL");
    if (b->finished || b->next_view || b->batch_count)
        return cohsm__refuse(&log, COHSM_ERR_ORDER, "the builder", "has views, or has ended");
    take.segments = segments;
    take.log = &log;
    result = cohsm__take_segments(b, &take, count);
    if (result == COHSM_OK) b->batch_begin = b->head.view_count;
    else b->finished = 1;
    return cohsm__log_result(&log, result);
}

/* ==== src/csm/query_tiles.h ==== */

/* ---- query: one tile through the way that suits it ---- */

/* Answers for a tile whose samples have one light: each pixel is decoded once. */
static void cohsm__run_one_light(cohsm__tile *t, const cohsm__kernels *kernels)
{
    cohsm__stream s;
    uint32_t cell;

    if (!cohsm__cell_of_light(t->maps, t->light_kind, cohsm__tile_light(t, 0), t->cell[0], &cell)) return;
    cohsm__stream_make(&s, t->maps, cell, t->query->bias, &t->work.kept);
    s.count = t->count;
    s.x = t->point[0];
    s.y = t->point[1];
    s.z = t->point[2];
    s.key = (int32_t *)t->pixel;
    s.depth = t->depth;
    s.list = t->place;
    kernels->one_light(&s, t->visible);
}

#ifndef COHSM_WITHOUT_SIMD
/* Does what cohsm__pcf does for the whole tile; sums are taken in the same order. */
static void cohsm__run_pcf(cohsm__tile *t, const cohsm__kernels *kernels)
{
    float (*const weight)[COHSM__TILE] = t->work.fractions.weight, dark[COHSM__TILE], map[COHSM__TILE];
    uint32_t corner, pixel;
    size_t i;

    memset(dark, 0, sizeof dark);
    kernels->cells(t);
    for (corner = 0; corner < 4; corner++) {
        kernels->project(t, corner);
        memset(map, 0, sizeof map);
        for (pixel = 0; pixel < 4; pixel++) {
            for (i = 0; i < t->count; i++) t->visible[i] = 1.0f;
            kernels->corner(t, pixel);
            kernels->search(t);
            for (i = 0; i < t->count; i++)
                map[i] += (pixel & 1u ? weight[2][i] : 1.0f - weight[2][i]) *
                          (pixel >> 1 ? weight[3][i] : 1.0f - weight[3][i]) * (1.0f - t->visible[i]);
        }
        for (i = 0; i < t->count; i++)
            dark[i] += (corner & 1u ? weight[0][i] : 1.0f - weight[0][i]) *
                       (corner >> 1 ? weight[1][i] : 1.0f - weight[1][i]) * map[i];
    }
    for (i = 0; i < t->count; i++) t->visible[i] = cohsm__lit_from_dark(dark[i]);
}
#endif

/* Answers for a tile in steps; returns 0 if the samples are of a kind that is treated one by one. */
static int cohsm__answer_in_steps(cohsm__tile *t, const cohsm__kernels *kernels)
{
    const cohsm_maps *m = t->maps;
    int shared = t->one_light && t->query->filter == COHSM_FILTER_NEAREST;
    size_t i;

#ifdef COHSM_WITHOUT_SIMD
    if (t->query->filter == COHSM_FILTER_PCF) return 0;
#endif
    if (!shared && (t->light_kind != COHSM_LIGHT_DIRECTION || m->head.domain != COHSM_DOMAIN_LATLONG))
        return 0;
    for (i = t->count; i % COHSM__STEP; i++) {      /* the last step is filled up with points of no use */
        t->point[0][i] = t->point[1][i] = t->point[2][i] = 0.0f;
        t->id[i] = 0;
    }
    for (i = t->one_light ? 0 : t->count; !shared && (i < t->count || i % COHSM__STEP); i++) {
        t->light[0][i] = t->light[0][0];
        t->light[1][i] = t->light[1][0];
        t->light[2][i] = t->light[2][0];
    }
#ifndef COHSM_WITHOUT_SIMD
    if (t->query->filter == COHSM_FILTER_PCF) {
        cohsm__run_pcf(t, kernels);
        return 1;
    }
#endif
    if (shared) cohsm__run_one_light(t, kernels);
    else {
        kernels->address(t);
        kernels->search(t);
    }
    return 1;
}

/* Turns a tile's lights from positions into directions, for which the same maps answer. A sample with
   nothing between it and its light gets a direction of length 0, which counts as lit; one that is to be
   refused, since the light lies inside the hull, also a bit. */
static void cohsm__aim_tile(cohsm__tile *t, uint32_t *refused)
{
    const cohsm__v3 first = cohsm__tile_light(t, 0);
    size_t i;

    for (i = 0; i < t->count; i++) {
        const cohsm__v3 l = t->one_light ? first : cohsm__tile_light(t, i), p = cohsm__tile_point(t, i);
        cohsm__v3 to = cohsm__v3_make(0.0f, 0.0f, 0.0f);
        if (cohsm__v3_finite(l)) {
            if (cohsm__light_refused(t->maps, l)) refused[i / 32] |= 1u << i % 32;
            else if (cohsm__hull_between(t->maps, p, l)) to = cohsm__v3_sub(l, p);
        }
        t->light[0][i] = to.x;
        t->light[1][i] = to.y;
        t->light[2][i] = to.z;
    }
    t->light_kind = COHSM_LIGHT_DIRECTION;
    t->one_light = 0;
}

static void cohsm__answer(cohsm__tile *t)
{
    const cohsm__kernels kernels = cohsm__choose_kernels(t->maps->simd);
    size_t i;
    for (i = 0; i < t->count; i++) t->visible[i] = 1.0f;
    if (cohsm__answer_in_steps(t, &kernels)) return;
    for (i = 0; i < t->count; i++) {
        t->pixel[i] = COHSM__NO_PIXEL;
        t->place[i] = 0;
        t->depth[i] = 0;
        cohsm__address(t, i);
    }
    if (t->query->filter != COHSM_FILTER_PCF) kernels.search(t);
}

static void cohsm__run_tile(cohsm__tile *t)
{
    uint32_t refused[COHSM__TILE / 32];
    size_t i;

    if (t->query->light_kind != COHSM_LIGHT_POSITION) {
        cohsm__answer(t);
        return;
    }
    memset(refused, 0, sizeof refused);
    cohsm__aim_tile(t, refused);
    cohsm__answer(t);
    for (i = 0; i < t->count; i++)
        if (refused[i / 32] >> i % 32 & 1u) t->visible[i] = COHSM_REFUSED;
    t->light_kind = COHSM_LIGHT_POSITION;
    t->one_light = t->query->one_light;
}

/* ==== src/csm/scene.h ==== */

/* ---- scene: samples to the objects' spaces and back ---- */

static size_t cohsm__light_size(const cohsm_maps *m, cohsm_light_kind kind)
{
    if (kind == COHSM_LIGHT_INDEX) return 4;
    return kind == COHSM_LIGHT_PARAMETER ? 4 * (size_t)m->head.dimensions : 12;
}

/* Loads the lights of the tile's samples, or the one light of all, and takes them to the object's space. */
static void cohsm__load_lights(cohsm__tile *t, const float *inverse)
{
    const cohsm_query *q = t->query;
    const cohsm__header *h = &t->maps->head;
    size_t size = cohsm__light_size(t->maps, q->light_kind),
           stride = q->light_stride ? q->light_stride : size, i;
    size_t count = t->one_light ? (t->count ? 1 : 0) : t->count;
    cohsm__v3 c = cohsm__v3_load(h->center), l;
    float per_radius = 1.0f / h->radius, v[3] = { 0, 0, 0 };

    i = 0;
    if (q->light_kind == COHSM_LIGHT_DIRECTION && !inverse && stride == 12 && !t->one_light)
        i = cohsm__choose_kernels(t->maps->simd)
                .load_vectors(t, (const float *)q->lights, cohsm__v3_make(0, 0, 0), 1.0f, t->light);
    for (; i < count; i++) {
        const char *from = (const char *)q->lights + stride * (t->one_light ? 0 : t->id[i]);
        if (q->light_kind == COHSM_LIGHT_INDEX) {
            memcpy(&t->cell[i], from, 4);
            continue;
        }
        if (q->light_kind == COHSM_LIGHT_PARAMETER) memcpy(v, from, size);
        else memcpy(v, from, sizeof v);
        l = cohsm__v3_load(v);
        if (q->light_kind == COHSM_LIGHT_DIRECTION && inverse) l = cohsm__m4_direction(inverse, l);
        if (q->light_kind == COHSM_LIGHT_POSITION && inverse) l = cohsm__m4_point(inverse, l);
        if (q->light_kind == COHSM_LIGHT_POSITION) l = cohsm__v3_scale(cohsm__v3_sub(l, c), per_radius);
        t->light[0][i] = l.x;
        t->light[1][i] = l.y;
        t->light[2][i] = l.z;
    }
}

static void cohsm__load_tile(cohsm__tile *t, const float *inverse)
{
    const cohsm_query *q = t->query;
    size_t stride = q->position_stride ? q->position_stride : 12, i = 0;
    cohsm__v3 c = cohsm__v3_load(t->maps->head.center), p;
    float per_radius = 1.0f / t->maps->head.radius, v[3];

    if (!inverse && stride == 12)
        i = cohsm__choose_kernels(t->maps->simd)
                .load_vectors(t, (const float *)(const void *)q->positions, c, per_radius, t->point);
    for (; i < t->count; i++) {
        memcpy(v, (const char *)q->positions + stride * t->id[i], sizeof v);
        p = cohsm__v3_load(v);
        if (inverse) p = cohsm__m4_point(inverse, p);
        p = cohsm__v3_scale(cohsm__v3_sub(p, c), per_radius);
        t->point[0][i] = p.x;
        t->point[1][i] = p.y;
        t->point[2][i] = p.z;
    }
    cohsm__load_lights(t, inverse);
}

/* Finds the cell of the light that all samples of a query have. Returns 0 if all samples are lit. */
static int cohsm__cell_of_query(const cohsm_maps *m, const cohsm_query *q, uint32_t *cell)
{
    float v[3] = { 0.0f, 0.0f, 0.0f };
    uint32_t index = 0;
    memcpy(q->light_kind == COHSM_LIGHT_INDEX ? (void *)&index : (void *)v, q->lights,
           cohsm__light_size(m, q->light_kind));
    return cohsm__cell_of_light(m, q->light_kind, cohsm__v3_load(v), index, cell);
}

/* Answers the whole batch at once if all points have one light; returns 0 if the batch is one that is treated
   in tiles. */
static int cohsm__run_stream(const cohsm_maps *m, const cohsm_query *q, float *visible)
{
    const cohsm__kernels kernels = cohsm__choose_kernels(m->simd);
    int32_t key[COHSM__STREAM], depth[COHSM__STREAM];
    uint32_t list[COHSM__STREAM], cell;
    cohsm__stream s;
    cohsm__kept kept;
    size_t first;

    if (!q->count || !q->one_light || q->filter != COHSM_FILTER_NEAREST ||
        q->light_kind == COHSM_LIGHT_POSITION)
        return 0;
    if (!cohsm__cell_of_query(m, q, &cell)) {
        for (first = 0; first < q->count; first++) visible[first] = 1.0f;
        return 1;
    }
    cohsm__keep_nothing(&kept);
    cohsm__stream_make(&s, m, cell, q->bias, &kept);
    s.stride = q->position_stride ? q->position_stride : 12;
    s.key = key;
    s.depth = depth;
    s.list = list;
    for (first = 0; first < q->count; first += s.count) {
        s.count = q->count - first < COHSM__STREAM ? q->count - first : (size_t)COHSM__STREAM;
        s.points = (const char *)(const void *)q->positions + s.stride * first;
        kernels.one_light(&s, visible + first);
    }
    return 1;
}

/* Says whether maps can answer for lights of the query's kind. */
static cohsm_result cohsm__check_light_kind(const cohsm_maps *m, const cohsm_query *q,
                                            const cohsm__logger *log)
{
    const double kind = (double)q->light_kind;

    if (q->light_kind == COHSM_LIGHT_INDEX) return COHSM_OK;
    if (q->light_kind == COHSM_LIGHT_PARAMETER) {
        if (m->head.dimensions) return COHSM_OK;
        cohsm__log_value(log, "query.light_kind", kind,
                         "COHSM_LIGHT_INDEX: maps of a LIST have no parameters");
        return COHSM_ERR_MISMATCH;
    }
    if (m->head.domain == COHSM_DOMAIN_LATLONG || m->head.domain == COHSM_DOMAIN_OCTAHEDRAL) return COHSM_OK;
    cohsm__log_value(log, "query.light_kind", kind,
                     "COHSM_LIGHT_PARAMETER or _INDEX: these are not maps of all directions");
    return COHSM_ERR_MISMATCH;
}

static cohsm_result cohsm__check_query(const cohsm_maps *m, const cohsm_query *q, const cohsm__logger *log)
{
    const char *stride = NULL;
    size_t bytes = 0;

    if (!q->positions) return cohsm__refuse(log, COHSM_ERR_ARGUMENT, "query.positions", "is NULL");
    if (!q->lights) return cohsm__refuse(log, COHSM_ERR_ARGUMENT, "query.lights", "is NULL");
    if ((unsigned)q->light_kind >= COHSM_LIGHT_COUNT)
        return cohsm__refuse_value(log, "query.light_kind", (double)q->light_kind, "a COHSM_LIGHT_...");
    if ((unsigned)q->filter >= COHSM_FILTER_COUNT)
        return cohsm__refuse_value(log, "query.filter", (double)q->filter, "a COHSM_FILTER_...");
    if (!cohsm__finite(q->bias)) return cohsm__refuse_value(log, "query.bias", (double)q->bias, "finite");
    if ((q->light_stride && q->light_stride < cohsm__light_size(m, q->light_kind)) || q->light_stride % 4) {
        stride = "query.light_stride";
        bytes = q->light_stride;
    }
    if ((q->position_stride && q->position_stride < 12) || q->position_stride % 4) {
        stride = "query.position_stride";
        bytes = q->position_stride;
    }
    if (!stride) return cohsm__check_light_kind(m, q, log);
    cohsm__log_value(log, stride, (double)bytes, "0, or a multiple of 4 with room for one element");
    return COHSM_ERR_ARGUMENT;
}

static size_t cohsm__count_refused(const float *visible, size_t count)
{
    size_t i, n = 0;
    for (i = 0; i < count; i++) n += visible[i] == COHSM_REFUSED;
    return n;
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

/* Returns the query with its default filled in: a bias of 0 is one pixel, a negative bias is none. */
static cohsm_query cohsm__complete_query(const cohsm_query *query)
{
    cohsm_query q = *query;
    if (q.bias == 0.0f) q.bias = 1.0f;
    if (q.bias < 0.0f) q.bias = 0.0f;
    return q;
}

COHSM_DEF cohsm_result cohsm_visible(const cohsm_maps *maps, const cohsm_query *query, float *visible,
                                     size_t *refused)
{
    cohsm_query q;
    cohsm__logger log = cohsm__logger_of_maps(maps, "cohsm_visible");
    cohsm_result result;

    if (!maps) return COHSM_ERR_ARGUMENT;
    if (!query) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "query", "is NULL");
    if (query->count && !visible) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "visible", "is NULL");
    if (query->count) {
        result = cohsm__check_query(maps, query, &log);
        if (result != COHSM_OK) return result;
    }
    q = cohsm__complete_query(query);
    if (!cohsm__run_stream(maps, &q, visible)) cohsm__run_tiles(maps, &q, visible);
    if (refused) *refused = cohsm__count_refused(visible, query->count);
    return COHSM_OK;
}

/* ==== src/csm/scene_instances.h ==== */

/* ---- scene: many instances ---- */

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

/* Returns an upper bound of the angle between a direction and that of the map which answers for it, in
   radians: half a cell with NEAREST, one cell with filters that take neighbours. */
static float cohsm__cell_angle(const cohsm__header *h, cohsm_filter filter)
{
    const float cells = filter == COHSM_FILTER_NEAREST ? 0.5f : 1.0f, turn = 6.2832f * cells;
    const float a = turn / (float)h->side[0], b = 0.5f * turn / (float)h->side[1];
    /* A step in the octahedral square turns a direction by at most 6.2 times its length. */
    if (h->domain == COHSM_DOMAIN_OCTAHEDRAL) return 6.2f * 1.4143f * cells / (float)h->side[0] + 1e-3f;
    return sqrtf(a * a + b * b) + 1e-3f;
}

/* Returns the radius of a sphere, in radii of the maps' own, outside which nothing shadows: the maps' sphere
   and a pixel across for directions, for positions a sphere round the hull, whose corners lie up to 1.13
   times as far from the centre as its faces. */
static float cohsm__sphere_reach(const cohsm_maps *m, cohsm_light_kind kind)
{
    float reach = 0.0f;
    int i;
    if (kind == COHSM_LIGHT_DIRECTION) return 1.0f + 2.83f / (float)m->head.map_side + 1e-3f;
    for (i = 0; i < 2 * COHSM__DOP_AXES; i++) {     /* axes have the lengths 1, sqrt(2) and sqrt(3) */
        const float d = fabsf(m->dop[i]) * (i < 6 ? 1.0f : i < 18 ? 0.70711f : 0.57736f);
        if (d > reach) reach = d;
    }
    return 1.13f * reach + 1e-3f;
}

static cohsm__sphere cohsm__sphere_of(const cohsm_instance *instance, const cohsm_query *q)
{
    const cohsm__header *h = &instance->maps->head;
    const float *transform = cohsm__m4_or_identity(instance->transform);
    const cohsm__v3 c = cohsm__m4_point(transform, cohsm__v3_load(h->center));
    const float scale = cohsm__v3_length(cohsm__v3_load(transform));
    float angle = 0.0f, sine, cosine;
    cohsm__sphere s;
    s.x = c.x;
    s.y = c.y;
    s.z = c.z;
    s.radius = cohsm__sphere_reach(instance->maps, q->light_kind) * h->radius * scale +
               COHSM__SLACK * (fabsf(c.x) + fabsf(c.y) + fabsf(c.z));
    if (q->light_kind == COHSM_LIGHT_DIRECTION) {
        angle = cohsm__cell_angle(h, q->filter);
        /* Pixels that nothing hits may shadow anything; a few cells are too wide to be worth a test. */
        if (h->self_only || angle >= 1.0f) {
            angle = 0.0f;
            s.radius = (float)HUGE_VAL;
        }
    }
    cohsm__sincos(angle, &sine, &cosine);
    s.cone_radius = s.radius / cosine;
    s.slope = sine / cosine;
    return s;
}

/* An instance's number, a block of the query's samples, and a bit for each that may have to ask it. */
typedef struct cohsm__asking {
    const cohsm_instance *instance;
    uint32_t       number;
    const uint32_t *asked;
    size_t         begin, count;
} cohsm__asking;

/* Asks one instance for those of a block's samples that still see some light. */
static void cohsm__ask_instance(cohsm__tile *t, const cohsm_query *q, const cohsm__asking *a, float *visible)
{
    float inverse[16];
    const size_t words = (a->count + 31) / 32;
    size_t word, i, n = 0;
    uint32_t bits;
    int started = 0;

    for (word = 0; word < words; word++) {
        bits = a->asked[word];
        if (!bits) continue;
        if (!started) {
            cohsm__tile_start(t, q, a->instance->maps, a->number);
            cohsm__m4_affine_inverse(inverse, cohsm__m4_or_identity(a->instance->transform));
            started = 1;
        }
        for (; bits; bits &= bits - 1u) {
            i = a->begin + 32 * word + cohsm__first_bit_plain(bits);
            t->id[n] = i;
            n += visible[i] > 0.0f;
            if (n < COHSM__TILE) continue;
            t->count = n;
            cohsm__flush_tile(t, inverse, visible);
            n = 0;
        }
    }
    t->count = n;
    if (n) cohsm__flush_tile(t, inverse, visible);
}

/* Finds the samples that a bunch of instances, from number `first` on, must be asked for: if own is 1, those
   that lie on one of them; if 0, all others whose rays may meet it. A sample of entity 0 lies on none. */
static void cohsm__find_asked(cohsm__bunch *b, const cohsm_instance *bunch, uint32_t first,
                              const cohsm_query *q, size_t begin, size_t count, int own, int tested)
{
    uint32_t j;
    size_t i;

    memset(b->asked, own || tested ? 0 : 0xff, sizeof b->asked);
    if (!own && tested) {
        for (j = 0; j < b->count; j++) b->sphere[j] = cohsm__sphere_of(&bunch[j], q);
        cohsm__choose_kernels(bunch->maps->simd).meet_spheres(q, begin, count, b);
    }
    for (j = 0; j < b->count && count % 32; j++) b->asked[j][count / 32] &= (1u << count % 32) - 1u;
    for (i = 0; q->entities && i < count; i++) {
        j = q->entities[begin + i] - 1u - first;
        if (j >= b->count) continue;
        if (own) b->asked[j][i / 32] |= 1u << i % 32;
        else b->asked[j][i / 32] &= ~(1u << i % 32);
    }
}

static cohsm_result cohsm__check_instance(const cohsm_instance *instance, size_t number, const cohsm_query *q,
                                          const cohsm__logger *log)
{
    const float *m = cohsm__m4_or_identity(instance->transform);
    float inverse[16], scale;

    if (!instance->maps) {
        cohsm__log_element_text(log, "instances", number, "has no maps");
        return COHSM_ERR_ARGUMENT;
    }
    if (!cohsm__m4_is_rigid_uniform(m, &scale) || !cohsm__m4_affine_inverse(inverse, m)) {
        cohsm__v3 z = cohsm__v3_cross(cohsm__v3_load(m), cohsm__v3_load(m + 4));
        cohsm__log_element(log, "instances", number, "has a transform of the determinant",
                           (double)cohsm__v3_dot(z, cohsm__v3_load(m + 8)),
                           "a rotation, one scale > 0 and a translation");
        return COHSM_ERR_INPUT;
    }
    return q->count ? cohsm__check_query(instance->maps, q, log) : COHSM_OK;
}

/* Returns the log of the first instance that has maps. If count is larger than any scene can be, the function
   looks at the first instance alone. */
static cohsm__logger cohsm__logger_of_scene(const cohsm_instance *instances, size_t count)
{
    const cohsm_maps *maps = NULL;
    size_t i, end = !instances ? 0 : count < UINT32_MAX ? count : 1;
    for (i = 0; i < end && !maps; i++) maps = instances[i].maps;
    return cohsm__logger_of_maps(maps, "cohsm_visible_scene");
}

/* Asks all instances for a block of samples: first, for each sample, the instance that it lies on, then the
   others in the order of the list. */
static void cohsm__ask_block(cohsm__tile *t, const cohsm_instance *instances, uint32_t instance_count,
                             const cohsm_query *q, size_t begin, size_t count, float *visible)
{
    /* The spheres of few instances are not worth their test. */
    const int tested = instance_count >= 4 &&
                       (q->light_kind == COHSM_LIGHT_DIRECTION || q->light_kind == COHSM_LIGHT_POSITION);
    cohsm__bunch b;
    cohsm__asking a;
    uint32_t first, j;
    int own;

    a.begin = begin;
    a.count = count;
    for (own = q->entities != NULL; own >= 0; own--)
        for (first = 0; first < instance_count; first += b.count) {
            b.count = cohsm__min_u32(instance_count - first, COHSM__BUNCH);
            cohsm__find_asked(&b, instances + first, first, q, begin, count, own, tested);
            for (j = 0; j < b.count; j++) {
                a.instance = &instances[first + j];
                a.number = first + j;
                a.asked = b.asked[j];
                cohsm__ask_instance(t, q, &a, visible);
            }
        }
}

COHSM_DEF cohsm_result cohsm_visible_scene(const cohsm_instance *instances, size_t instance_count,
                                           const cohsm_query *query, float *visible, size_t *refused)
{
    cohsm__tile t;
    cohsm_query q;
    size_t i, n;
    cohsm__logger log = cohsm__logger_of_scene(instances, instance_count);
    cohsm_result result;

    if (!query) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "query", "is NULL");
    if (query->count && !visible) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "visible", "is NULL");
    if (instance_count && !instances) return COHSM_ERR_ARGUMENT;
    if (instance_count >= UINT32_MAX) {
        cohsm__log_value(&log, "instance_count", (double)instance_count, "below 2^32 - 1");
        return COHSM_ERR_LIMIT;
    }
    for (i = 0; i < instance_count; i++) {
        result = cohsm__check_instance(&instances[i], i, query, &log);
        if (result != COHSM_OK) return result;
    }
    q = cohsm__complete_query(query);
    if (instance_count == 1) q.entities = NULL;             /* entities decide the order alone */
    for (i = 0; i < q.count; i++) visible[i] = 1.0f;
    for (i = 0; i < q.count; i += n) {
        n = q.count - i < COHSM__BLOCK ? q.count - i : (size_t)COHSM__BLOCK;
        cohsm__ask_block(&t, instances, (uint32_t)instance_count, &q, i, n, visible);
    }
    if (refused) *refused = cohsm__count_refused(visible, query->count);
    return COHSM_OK;
}

/* ==== src/csm/seeing.h ==== */

/* ---- seeing: one receiver and many lights, for headers that gather light ---- */

enum { COHSM__SEEN = 64 };              /* lights that are asked about at a time */

/* Writes the lights with these numbers one after another, 12 bytes apart, as a query reads them. */
static void cohsm__pick_lights(const cohsm_sight *s, const uint32_t *numbers, size_t count,
                               float lights[3 * COHSM__SEEN])
{
    const cohsm_query *q = &s->query;
    const size_t size = cohsm__light_size(s->instances[0].maps, q->light_kind);
    const size_t stride = q->light_stride ? q->light_stride : size;
    size_t i;

    memset(lights, 0, 3 * COHSM__SEEN * sizeof *lights);
    for (i = 0; i < count; i++)
        memcpy(lights + 3 * i,
               q->lights ? (const void *)((const char *)q->lights + stride * numbers[i])
                         : (const void *)(numbers + i),
               size);
}

/* Asks about up to COHSM__SEEN lights. Each receiver has random numbers of its own for ROULETTE, by the bits
   of its position. */
static cohsm_result cohsm__see_some(const cohsm_sight *s, const float position[3], const uint32_t *numbers,
                                    size_t count, float *visible)
{
    float positions[3 * COHSM__SEEN], lights[3 * COHSM__SEEN];
    cohsm_query q = s->query;
    uint32_t bits[3];
    size_t i;

    for (i = 0; i < count; i++) memcpy(positions + 3 * i, position, 3 * sizeof *position);
    if (q.lights || q.light_kind == COHSM_LIGHT_INDEX) {
        cohsm__pick_lights(s, numbers, count, lights);
        q.lights = lights;
    }
    memcpy(bits, position, sizeof bits);
    q.seed = cohsm__hash_combine(cohsm__hash_combine(cohsm__hash_combine(q.seed, bits[0]), bits[1]), bits[2]);
    q.positions = positions;
    q.position_stride = 12;
    q.light_stride = 12;
    q.count = count;
    q.one_light = 0;
    q.entities = NULL;
    return cohsm_visible_scene(s->instances, s->instance_count, &q, visible, NULL);
}

COHSM_DEF void cohsm_see(void *sight, const float position[3], const float normal[3],
                         const uint32_t *numbers, size_t count, float *visible)
{
    const cohsm_sight *s = (const cohsm_sight *)sight;
    size_t first, i, n;

    (void)normal;
    for (first = 0; first < count; first += n) {
        const int known = s->instance_count > 0 && s->instances && s->instances[0].maps;
        n = count - first < COHSM__SEEN ? count - first : (size_t)COHSM__SEEN;
        for (i = 0; i < n; i++) visible[first + i] = s->instance_count ? 0.0f : 1.0f;
        if (!known) continue;
        if (cohsm__see_some(s, position, numbers + first, n, visible + first) != COHSM_OK)
            for (i = 0; i < n; i++) visible[first + i] = 0.0f;
        for (i = 0; i < n; i++)
            if (visible[first + i] < 0.0f) visible[first + i] = 1.0f;
    }
}

COHSM_DEF void cohsm_light_locations(const float *positions, size_t position_stride, const float *normals,
                                     size_t normal_stride, size_t count, float lift, float *locations)
{
    const char *p = (const char *)(const void *)positions, *n = (const char *)(const void *)normals;
    size_t i;

    for (i = 0; i < count; i++, locations += 4) {
        float at[3], normal[3];
        memcpy(at, p + i * (position_stride ? position_stride : 12), sizeof at);
        memcpy(normal, n + i * (normal_stride ? normal_stride : 12), sizeof normal);
        cohsm__v3_store(locations,
                        cohsm__v3_add(cohsm__v3_load(at), cohsm__v3_scale(cohsm__v3_load(normal), lift)));
        locations[3] = 1.0f;
    }
}

/* ==== src/csm/raster_views.h ==== */

/* ---- raster: whole views, clipped where they are perspective ---- */

/* Triangles of perspective views are cut to |x|, |y| <= 2 w, so that fixed-point positions stay small, and to
   w >= near. */
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

/* Computes the cut from the inner end, whichever way the edge runs, so that both triangles of the edge get
   the same corner. */
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

static cohsm__corner cohsm__project_corner(const cohsm__clip *c, int size)
{
    cohsm__corner p;
    float scale = (float)(size * (COHSM__SUBPIXEL / 2)), inverse = 1.0f / c->w, offset = scale * 3.0f + 0.5f;
    /* The offset by one image makes the number positive, so that conversion to int truncates downwards
       everywhere. */
    p.x = (int32_t)(c->x * inverse * scale + offset) - size * COHSM__SUBPIXEL;
    p.y = (int32_t)(c->y * inverse * scale + offset) - size * COHSM__SUBPIXEL;
    p.z = inverse;
    return p;
}

/* Begins the mask of triangle `lane` of a cluster. Returns NULL if the mesh has none. */
static cohsm__mask *cohsm__mask_begin(const cohsm__soup *soup, uint32_t cluster, uint32_t lane,
                                      cohsm__mask *mask)
{
    uint32_t number = cluster * COHSM__CLUSTER + lane;
    if (!soup->masked || number >= soup->triangles) return NULL;
    mask->mesh = soup->masked;
    mask->triangle = soup->source[number];
    return mask;
}

static void cohsm__mask_corner(cohsm__mask *mask, int corner, float x, float y, float w)
{
    mask->corners[3 * corner] = (double)x;
    mask->corners[3 * corner + 1] = (double)y;
    mask->corners[3 * corner + 2] = (double)w;
}

static void cohsm__raster_perspective(const cohsm__target *t, const cohsm__camera *cam,
                                      const cohsm__soup *soup, uint32_t cluster, uint32_t lane)
{
    const float *v = cohsm__cluster(soup, cluster);
    cohsm__mask storage, *mask = cohsm__mask_begin(soup, cluster, lane, &storage);
    cohsm__clip p[10];
    cohsm__corner c0, c1, c2;
    int k, n = 3, behind = 0;
    int left = 0, right = 0, below = 0, above = 0;
    int inside = 0;

    for (k = 0; k < 3; k++, v += 3 * COHSM__CLUSTER) {
        cohsm__v3 q = cohsm__v3_sub(cohsm__v3_make(v[lane], v[16 + lane], v[32 + lane]), cam->eye);
        cohsm__face_coordinates(cam->face, q, &p[k].x, &p[k].y, &p[k].w);
        if (mask) cohsm__mask_corner(mask, k, p[k].x, p[k].y, p[k].w);
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
    c0 = cohsm__project_corner(p, t->size);
    c1 = cohsm__project_corner(p + 1, t->size);
    for (k = 2; k < n; k++) {
        c2 = cohsm__project_corner(p + k, t->size);
        cohsm__fill_triangle(t, cam, mask, &c0, &c1, &c2);
        c1 = c2;
    }
}

/* Says whether the unit sphere can be seen in this face at all. */
static int cohsm__face_sees_sphere(const cohsm__camera *cam)
{
    cohsm__v3 q = cohsm__v3_scale(cam->eye, -1.0f);
    float x, y, w;
    cohsm__face_coordinates(cam->face, q, &x, &y, &w);
    return w > -1.001f && fabsf(x) - w < 1.4157f && fabsf(y) - w < 1.4157f;
}

/* Appends to a list the numbers, from first on, of the bits that are set. Returns the new count. */
static uint32_t cohsm__append_set_bits(uint32_t *list, uint32_t count, unsigned mask, uint32_t first)
{
    for (; mask; mask >>= 1, first++)
        if (mask & 1u) list[count++] = first;
    return count;
}

/* Finds those of the clusters begin .. end - 1, no more than a stretch, that may be in sight of a perspective
   view: by the boxes of eight clusters first. */
static void cohsm__find_in_face(const cohsm__target *t, const cohsm__camera *cam, const cohsm__soup *soup,
                                uint32_t begin, uint32_t end, cohsm__sight *sight)
{
    const float *wide = cohsm__wide_bounds(soup);
    uint32_t eight[COHSM__STRETCH / 8 + 8], eights = cohsm__groups_of_8(end), count = 0, i;
    unsigned mask;

    for (i = begin / 8; i < eights; i += 8) {
        mask = cohsm__face_sees8(t, cam, wide + 6 * (size_t)i) & cohsm__first8(eights - i);
        count = cohsm__append_set_bits(eight, count, mask, i);
    }
    for (i = 0, sight->count = 0; i < count; i++) {
        mask = cohsm__face_sees8(t, cam, soup->bounds + 48 * (size_t)eight[i]) &
               cohsm__first8(end - 8 * eight[i]);
        sight->count = cohsm__append_set_bits(sight->cluster, sight->count, mask, 8 * eight[i]);
    }
}

static void cohsm__raster_face(const cohsm__target *t, const cohsm__camera *cam, const cohsm__soup *soup)
{
    cohsm__sight sight;
    uint32_t begin, end, i, k;

    if (!cohsm__face_sees_sphere(cam)) return;
    for (begin = 0; begin < soup->clusters; begin = end) {
        end = cohsm__min_u32(begin + COHSM__STRETCH, soup->clusters);
        cohsm__find_in_face(t, cam, soup, begin, end, &sight);
        for (i = 0; i < sight.count; i++)
            for (k = 0; k < COHSM__CLUSTER; k++)
                cohsm__raster_perspective(t, cam, soup, sight.cluster[i], k);
    }
}

/* Draws a triangle of an orthographic view as the kernels do, to the last bit, but for the holes of its
   mask. */
static void cohsm__raster_masked(const cohsm__target *t, const cohsm__camera *cam, const cohsm__soup *soup,
                                 uint32_t cluster, uint32_t lane)
{
    const float scale = (float)(t->size * (COHSM__SUBPIXEL / 2)), offset = scale + 0.5f;
    const cohsm__v3 right = cohsm__v3_scale(cam->axes.right, scale);
    const cohsm__v3 up = cohsm__v3_scale(cam->axes.up, scale);
    const float *v = cohsm__cluster(soup, cluster);
    cohsm__mask mask;
    cohsm__corner c[3];
    int k;

    if (!cohsm__mask_begin(soup, cluster, lane, &mask)) return;
    for (k = 0; k < 3; k++, v += 3 * COHSM__CLUSTER) {
        cohsm__v3 p = cohsm__v3_make(v[lane], v[16 + lane], v[32 + lane]);
        c[k].x = (int32_t)(cohsm__v3_dot(p, right) + offset);
        c[k].y = (int32_t)(cohsm__v3_dot(p, up) + offset);
        c[k].z = 0.5f - 0.5f * cohsm__v3_dot(p, cam->axes.back);
        cohsm__mask_corner(&mask, k, cohsm__v3_dot(p, cam->axes.right), cohsm__v3_dot(p, cam->axes.up), 1.0f);
    }
    cohsm__fill_triangle(t, cam, &mask, c, c + 1, c + 2);
}

/* Draws a perspective view, or an orthographic one of a mesh with a mask. */
static void cohsm__raster_view(const cohsm__target *t, const cohsm__camera *cam, const cohsm__soup *soup,
                               int simd)
{
    size_t first = (size_t)(t->row_begin * t->size) * t->keep;
    size_t last = (size_t)(t->row_end * t->size) * t->keep;
    int all = t->row_begin == 0 && t->row_end == t->size;
    cohsm__kernels kernels = cohsm__choose_kernels(simd);
    uint32_t begin, end, i;
    cohsm__sight sight;

    memset(t->z + first, 0xff, (last - first) * sizeof *t->z);
    if (cam->perspective) {
        cohsm__raster_face(t, cam, soup);
        return;
    }
    for (begin = 0; begin < soup->clusters; begin = end) {
        end = cohsm__min_u32(begin + COHSM__STRETCH, soup->clusters);
        for (i = begin; all && i < end; i++) sight.cluster[i - begin] = i;
        sight.count = end - begin;
        if (!all) kernels.find(t, cam->axes.up, soup, begin, end, &sight);
        for (i = 0; i < sight.count * COHSM__CLUSTER; i++)
            cohsm__raster_masked(t, cam, soup, sight.cluster[i / COHSM__CLUSTER], i % COHSM__CLUSTER);
    }
}

/* Lists those of the clusters begin .. end - 1, no more than a stretch, that one of the views may see. */
static void cohsm__sight_of_column(const cohsm__target *t, const cohsm__camera *cam, uint32_t count,
                                   const cohsm__soup *soup, const cohsm__kernels *kernels, uint32_t begin,
                                   uint32_t end, cohsm__sight *sight)
{
    const int all = t->row_begin == 0 && t->row_end == t->size;
    uint8_t seen[COHSM__STRETCH];
    uint32_t i, k;

    memset(seen, all, sizeof seen);
    for (i = 0; !all && i < count; i++) {
        kernels->find(t + i, cam[i].axes.up, soup, begin, end, sight);
        for (k = 0; k < sight->count; k++) seen[sight->cluster[k] - begin] = 1;
    }
    for (k = begin, sight->count = 0; k < end; k++)
        if (seen[k - begin]) sight->cluster[sight->count++] = k;
}

static int cohsm__right_is_same(const cohsm__camera *a, const cohsm__camera *b)
{
    return !memcmp(&a->axes.right, &b->axes.right, sizeof a->axes.right);
}

/* Draws orthographic views of a mesh without a mask, faster if their axes to the right are the same. */
static void cohsm__raster_column(const cohsm__target *t, const cohsm__camera *cam, uint32_t count,
                                 const cohsm__soup *soup, int simd, cohsm__column *column)
{
    const size_t first = (size_t)(t->row_begin * t->size) * t->keep;
    const size_t last = (size_t)(t->row_end * t->size) * t->keep;
    const cohsm__kernels kernels = cohsm__choose_kernels(simd);
    uint32_t begin, end, at, i;
    cohsm__sight sight;

    for (i = 0; i < count; i++) memset(t[i].z + first, 0xff, (last - first) * sizeof *t->z);
    for (begin = 0; begin < soup->clusters; begin = end) {
        end = cohsm__min_u32(begin + COHSM__STRETCH, soup->clusters);
        cohsm__sight_of_column(t, cam, count, soup, &kernels, begin, end, &sight);
        for (at = 0; at < sight.count; at += (uint32_t)COHSM__SLAB / COHSM__CLUSTER) {
            for (i = 0; i < count; i++) {
                if (!i || !cohsm__right_is_same(cam + i, cam + i - 1))
                    kernels.find_slab(t + i, cam + i, soup, &sight, at, &column->slab);
                kernels.enqueue_slab(t + i, cam + i, &column->slab, column->queue + i);
            }
        }
    }
    for (i = 0; i < count; i++) kernels.draw_queue(t + i, cam + i, column->queue + i, 1);
}

/* ==== src/csm/build.h ==== */

/* ---- build: from a mesh ---- */

/* The views of a trial, by face and cell, from which the next trial takes them in another order. */
typedef struct cohsm__shelf { uint16_t *z; int filled; } cohsm__shelf;
#define COHSM__SHELF_BYTES ((size_t)1 << 25)        /* larger trials draw their views for each order */

/* The views of a batch that are drawn together. */
typedef struct cohsm__group { uint32_t view[COHSM__ABREAST], count; } cohsm__group;

/* A batch of a Hilbert curve is eight columns of eight views, or 16 with threads: for each task a column. */
enum { COHSM__COLUMNS = (int)COHSM__BATCH / (int)COHSM__ABREAST };

typedef struct cohsm__job {
    cohsm_builder *builder;
    const cohsm__soup *soup;
    const cohsm__shelf *shelf;          /* NULL: none */
    cohsm__column *columns;             /* NULL: every view is drawn alone */
    uint32_t column_count;
    void *memory;                       /* where the columns lie, on whole cache lines */
    int simd;
    cohsm__camera cameras[COHSM__BATCH];
    cohsm__group groups[COHSM__BATCH];  /* no more than column_count of views that are drawn together */
    uint32_t group_count;
} cohsm__job;

/* Returns the shelf's place for a view of the batch, or NULL. */
static uint16_t *cohsm__on_shelf(const cohsm__job *job, uint32_t i)
{
    const cohsm_builder *b = job->builder;
    const uint32_t view = b->batch_begin + i, cell = b->cells[view % b->head.map_count];
    const size_t at = (size_t)(view / b->head.map_count) * b->head.map_count + cell;
    return job->shelf ? job->shelf->z + at * b->batch_size : NULL;
}

static cohsm__target cohsm__batch_target(const cohsm_builder *b, uint32_t i)
{
    const uint32_t m = b->head.map_side;
    cohsm__target target;
    target.z = b->batch + (size_t)i * b->batch_size;
    target.keep = b->keep;
    target.size = (int)m;
    target.row_begin = (int)(b->desc.pixel_begin / m);
    target.row_end = (int)((b->desc.pixel_end + m - 1u) / m);
    return target;
}

static void cohsm__raster_task(void *context, size_t index)
{
    const cohsm__job *job = (const cohsm__job *)context;
    const cohsm_builder *b = job->builder;
    const cohsm__group *group = job->groups + index;
    cohsm__camera cameras[COHSM__ABREAST];
    cohsm__target targets[COHSM__ABREAST];
    uint32_t i, p;

    for (i = 0; i < group->count; i++) {
        targets[i] = cohsm__batch_target(b, group->view[i]);
        cameras[i] = job->cameras[group->view[i]];
    }
    if (job->shelf && job->shelf->filled) {
        for (i = 0; i < group->count; i++)
            memcpy(targets[i].z, cohsm__on_shelf(job, group->view[i]), b->batch_size * sizeof *b->batch);
        return;
    }
    if (!job->columns) cohsm__raster_view(targets, cameras, job->soup, job->simd);
    else cohsm__raster_column(targets, cameras, group->count, job->soup, job->simd, job->columns + index);
    for (i = 0; i < group->count; i++) {
        if (b->desc.layers == COHSM_LAYERS_Z1Z3_SPHERE)
            for (p = b->desc.pixel_begin; p < b->desc.pixel_end; p++)
                targets[i].z[4 * (size_t)p + 3] = cohsm__leave_depth(cameras + i, b->head.map_side, p);
        if (job->shelf)
            memcpy(cohsm__on_shelf(job, group->view[i]), targets[i].z, b->batch_size * sizeof *b->batch);
    }
}

/* Says whether views are drawn together where they can be: those of directions, without masks. */
static int cohsm__draws_columns(const cohsm_builder *b, const cohsm__soup *soup)
{
    return !b->head.positional && !soup->masked;
}

/* Finds the group that a view of the batch joins, or makes one for it. Views of one axis to the right are
   together, as long as there is room for others to be apart. */
static cohsm__group *cohsm__group_of(cohsm__job *job, const cohsm__camera *cam)
{
    cohsm__group *space = NULL;
    uint32_t g, k;
    for (g = 0; job->columns && g < job->group_count; g++) {
        if (job->groups[g].count == COHSM__ABREAST) continue;
        if (!space) space = job->groups + g;
        for (k = 0; k < job->groups[g].count; k++)
            if (cohsm__right_is_same(job->cameras + job->groups[g].view[k], cam)) return job->groups + g;
    }
    if (space && job->group_count == job->column_count) return space;
    job->groups[job->group_count].count = 0;
    return job->groups + job->group_count++;
}

/* Adds a view to a group, behind one of the same axis to the right if there is one. */
static void cohsm__group_add(const cohsm__job *job, cohsm__group *group, uint32_t view)
{
    const cohsm__camera *cam = job->cameras + view;
    uint32_t at = group->count, k;
    while (at && !cohsm__right_is_same(job->cameras + group->view[at - 1u], cam)) at--;
    if (!at) at = group->count;
    for (k = group->count++; k > at; k--) group->view[k] = group->view[k - 1u];
    group->view[at] = view;
}

/* Sets up the cameras of the batch, and groups them. */
static void cohsm__group_views(cohsm__job *job)
{
    const cohsm_builder *b = job->builder;
    uint32_t i, view;

    for (i = 0, job->group_count = 0; i < b->batch_count; i++) {
        view = b->batch_begin + i;
        job->cameras[i] = cohsm__camera_of(&b->head, b->locations, b->angles,
                                           b->cells[view % b->head.map_count], view / b->head.map_count);
        cohsm__group_add(job, cohsm__group_of(job, job->cameras + i), i);
    }
}

static size_t cohsm__column_bytes(const cohsm__job *job)
{
    return job->column_count * sizeof *job->columns + COHSM__LINE_BYTES;
}

/* Makes ready to draw batches; shelf: NULL = none. Returns 0 if memory runs out, when nothing has begun. */
static int cohsm__job_begin(cohsm__job *job, cohsm_builder *b, const cohsm__soup *soup,
                            const cohsm__shelf *shelf)
{
    memset(job, 0, sizeof *job);
    job->builder = b;
    job->soup = soup;
    job->shelf = shelf;
    job->simd = cohsm__simd();
    if (!cohsm__draws_columns(b, soup)) return 1;
    job->column_count = (uint32_t)COHSM__COLUMNS / (b->desc.system.parallel_for ? 1u : 2u);
    job->memory = cohsm__heap_alloc(&b->heap, cohsm__column_bytes(job), 1);
    if (!job->memory) return 0;
    /* Kernels compute with whole vectors, also of entries that nothing was written to, and leave these out
       later. */
    memset(job->memory, 0, cohsm__column_bytes(job));
    job->columns = (cohsm__column *)(void *)(
        (char *)job->memory + (0u - (uintptr_t)job->memory) % COHSM__LINE_BYTES);
    return 1;
}

static void cohsm__job_end(cohsm__job *job)
{
    cohsm__heap_free(&job->builder->heap, job->memory, cohsm__column_bytes(job), 1);
}

/* Draws the views of the batch. */
static void cohsm__draw_batch(cohsm__job *job)
{
    cohsm__group_views(job);
    cohsm__run_tasks(&job->builder->desc.system, job->group_count, cohsm__raster_task, job);
}

/* Draws and compresses all views. A shelf that is not NULL receives them, or gives them if it is filled. */
static cohsm_result cohsm__build_views(cohsm_builder *b, const cohsm__soup *soup, const cohsm__shelf *shelf)
{
    cohsm__job job;
    cohsm_result result = COHSM_OK;

    if (!cohsm__job_begin(&job, b, soup, shelf)) return COHSM_ERR_ALLOC;
    while (result == COHSM_OK && b->next_view < b->head.view_count) {
        if (b->desc.system.progress &&
            b->desc.system.progress(b->desc.system.user, (float)b->next_view / (float)b->head.view_count)) {
            result = COHSM_ERR_CANCELLED;
            break;
        }
        b->batch_count = cohsm__min_u32(b->batch_views, b->head.view_count - b->next_view);
        cohsm__draw_batch(&job);
        result = cohsm__close_batch(b);
    }
    cohsm__job_end(&job);
    return result;
}

/* A mesh made ready for rendering: its triangles and its k-DOP. The sphere goes into the desc. */
typedef struct cohsm__model { cohsm__soup soup; float dop[2 * COHSM__DOP_AXES]; } cohsm__model;

/* Fits the sphere, unless the desc has one, and the k-DOP. Returns COHSM_ERR_MISMATCH, which its callers turn
   into what they say, if the mesh reaches out of the sphere of the desc. */
static cohsm_result cohsm__model_bound(cohsm__model *model, cohsm_desc *d, const cohsm__points *points,
                                       const cohsm__logger *log)
{
    const int is_given = d->radius > 0.0f;

    if (!is_given) cohsm__fit_sphere(points, d->center, &d->radius);
    else if (!cohsm__sphere_holds(points, d->center, d->radius)) return COHSM_ERR_MISMATCH;
    if (!cohsm__radius_usable(d->radius)) {
        cohsm__log_value(log, is_given ? "desc.radius" : "the radius of mesh", (double)d->radius,
                         "above 1e-18, below 1e18");
        return is_given ? COHSM_ERR_DESC : COHSM_ERR_INPUT;
    }
    cohsm__dop_of_points(model->dop, points);
    return COHSM_OK;
}

static cohsm_result cohsm__model_make(cohsm__model *model, cohsm_desc *d, const cohsm_mesh *mesh,
                                      cohsm__counted_heap *heap, cohsm_stats *stats, const cohsm__logger *log)
{
    size_t count;
    uint8_t *used;
    cohsm__points points;
    cohsm_result result = cohsm__check_mesh(mesh, log);

    if (result != COHSM_OK) return result;
    count = cohsm__triangle_count(mesh);
    used = (uint8_t *)cohsm__heap_alloc(heap, count, 1);
    if (!used) return cohsm__log_result(log, COHSM_ERR_ALLOC);
    result = cohsm__select_triangles(mesh, used, heap, stats);
    if (result == COHSM_ERR_INPUT) cohsm__log_text(log, "mesh", "has no triangle that can be used");
    if (result == COHSM_OK) {
        result = COHSM_ERR_ALLOC;
        if (cohsm__points_make(&points, mesh, used, stats->triangles, heap))
            result = cohsm__model_bound(model, d, &points, log);
        cohsm__points_free(&points, heap);
    }
    if (result == COHSM_OK &&
        !cohsm__soup_make(&model->soup, mesh, used, stats->triangles, d->center, d->radius, heap))
        result = COHSM_ERR_ALLOC;
    cohsm__heap_free(heap, used, count, 1);
    return cohsm__log_result(log, result);
}

static cohsm_result cohsm__build_model(const cohsm_desc *d, const cohsm__model *model,
                                       cohsm__counted_heap *heap, cohsm_maps **out, cohsm_stats *stats)
{
    cohsm_builder *b;
    cohsm_result result = cohsm__builder_make(d, heap, &b);

    if (result != COHSM_OK) return result;
    memcpy(b->head.dop, model->dop, sizeof model->dop);
    result = cohsm__build_views(b, &model->soup, NULL);
    if (result == COHSM_OK) result = cohsm__finish_maps(b, out, stats);
    cohsm__drop_builder(b, heap);
    return result;
}

/* Counts the segments of a build. */
static cohsm_result cohsm__count_segments(const cohsm_desc *d, const cohsm__model *model,
                                          const cohsm__shelf *shelf, cohsm__counted_heap *heap,
                                          double *segments)
{
    cohsm_builder *b;
    cohsm_result result = cohsm__builder_make(d, heap, &b);
    int i;

    if (result != COHSM_OK) return result;
    b->counting = 1;
    result = cohsm__build_views(b, &model->soup, shelf);
    for (i = 0, *segments = 0.0; i < COHSM__RANGES; i++) *segments += (double)b->ranges[i].segments;
    cohsm__drop_builder(b, heap);
    return result;
}

/* The orders and the orientations among which a build chooses. */
typedef struct cohsm__choice {
    cohsm_order       order[2];
    cohsm_orientation orientation[2];
    int               orders, orientations;
    double            segments[2][2][2];    /* by order, orientation, and size: larger trial, smaller */
} cohsm__choice;

/* Returns the desc of a trial whose sides are divided by shrink, at half the map size. */
static cohsm_desc cohsm__small_desc(const cohsm_desc *d, uint32_t shrink, cohsm__step_system *step)
{
    cohsm_desc trial = *d;
    int i;

    cohsm__system_for_step(&trial.system, step, 0.0f, 0.0f);
    for (i = 0; i < 3; i++) trial.domain.side[i] = (d->domain.side[i] + shrink - 1u) / shrink;
    trial.map_side = cohsm__max_u32(d->map_side / 2, 8);
    trial.pixel_begin = 0;
    trial.pixel_end = trial.map_side * trial.map_side;
    return trial;
}

/* Returns how many depths all views of a trial have, or 0 if a shelf for them were too large. */
static size_t cohsm__shelf_depths(const cohsm_desc *d)
{
    const uint32_t faces = cohsm__is_positional(&d->domain) ? 6u : 1u, *s = d->domain.side;
    const uint64_t views = (uint64_t)s[0] * s[1] * s[2] * faces;
    const uint64_t view = (uint64_t)d->map_side * d->map_side * (d->layers == COHSM_LAYERS_Z1Z2 ? 2u : 4u);
    return views * view <= COHSM__SHELF_BYTES / 2 ? (size_t)(views * view) : 0;
}

/* Counts the segments of all orders with one orientation, whose views are drawn once. */
static cohsm_result cohsm__try_orders(const cohsm_desc *d, const cohsm__model *model, cohsm__choice *choice,
                                      int orientation, int size, uint32_t shrink, cohsm__counted_heap *heap)
{
    cohsm__step_system step;
    cohsm_desc trial = cohsm__small_desc(d, shrink, &step);
    cohsm__shelf shelf;
    const size_t depths = choice->orders > 1 ? cohsm__shelf_depths(&trial) : 0;
    cohsm_result result = COHSM_OK;
    int o;

    memset(&shelf, 0, sizeof shelf);
    if (depths) shelf.z = (uint16_t *)cohsm__heap_alloc(heap, depths, sizeof *shelf.z);
    if (depths && !shelf.z) return COHSM_ERR_ALLOC;
    trial.orientation = choice->orientation[orientation];
    for (o = 0; o < choice->orders && result == COHSM_OK; o++) {
        trial.order = choice->order[o];
        result = cohsm__count_segments(&trial, model, shelf.z ? &shelf : NULL, heap,
                                       &choice->segments[o][orientation][size]);
        shelf.filled = 1;
    }
    cohsm__heap_free(heap, shelf.z, depths, sizeof *shelf.z);
    return result;
}

/* Takes the order and the orientation of the fewest segments: those of the larger trial, continued by the
   growth from the smaller one for as many doublings as bring the larger to the full size. */
static void cohsm__take_best(cohsm_desc *d, const cohsm__choice *choice, uint32_t shrink)
{
    double least = 0.0, segments, growth;
    uint32_t k;
    int o, f;

    for (o = 0; o < choice->orders; o++)
        for (f = 0; f < choice->orientations; f++) {
            segments = choice->segments[o][f][0];
            growth = shrink > 1 ? segments / choice->segments[o][f][1] : 1.0;       /* by one doubling */
            for (k = shrink; k > 1; k /= 2) segments *= growth;
            if (least > 0.0 && segments >= least) continue;
            least = segments;
            d->order = choice->order[o];
            d->orientation = choice->orientation[f];
        }
}

/* Chooses order and orientation if the desc leaves them open. Each is tried at a quarter and an eighth of
   each side, and its segments are continued by that growth for two more doublings, since zig-zag is ahead of
   Hilbert on few maps and falls behind on many. Below 8 maps a side such growth says little, so that small
   domains are tried at a half, or whole. */
static cohsm_result cohsm__choose_sequence(cohsm_desc *d, const cohsm__model *model,
                                           cohsm__counted_heap *heap)
{
    const uint32_t shrink = d->domain.side[0] >= 32 ? 4 : d->domain.side[0] >= 16 ? 2 : 1;
    const int tabled = cohsm__has_table((uint32_t)d->domain.kind);
    cohsm__choice choice;
    cohsm_result result = COHSM_OK;
    int f;

    memset(&choice, 0, sizeof choice);
    choice.orders = d->order == COHSM_ORDER_DEFAULT && !tabled ? 2 : 1;
    choice.orientations =
        d->orientation == COHSM_ORIENTATION_DEFAULT && !tabled && !cohsm__is_positional(&d->domain) ? 2 : 1;
    if (d->order == COHSM_ORDER_DEFAULT) d->order = COHSM_ORDER_HILBERT;
    if (d->orientation == COHSM_ORIENTATION_DEFAULT) d->orientation = COHSM_ORIENTATION_POLAR;
    if (choice.orders == 1 && choice.orientations == 1) return COHSM_OK;
    choice.order[0] = d->order;
    choice.order[1] = COHSM_ORDER_ZIGZAG_THETA;
    choice.orientation[0] = d->orientation;
    choice.orientation[1] = COHSM_ORIENTATION_TWO_POLES;
    for (f = 0; f < choice.orientations && result == COHSM_OK; f++) {
        result = cohsm__try_orders(d, model, &choice, f, 0, shrink, heap);
        if (result == COHSM_OK && shrink > 1)
            result = cohsm__try_orders(d, model, &choice, f, 1, 2 * shrink, heap);
    }
    if (result == COHSM_OK) cohsm__take_best(d, &choice, shrink);
    return result;
}

/* Does what cohsm_build does, for the public function that the log names. */
static cohsm_result cohsm__build_for(const char *function, const cohsm_desc *desc, const cohsm_mesh *mesh,
                                     cohsm_maps **out, cohsm_stats *stats)
{
    cohsm_desc d;
    cohsm_stats s;
    cohsm__counted_heap heap;
    cohsm__model model;
    cohsm__logger log;
    cohsm_maps *maps = NULL;
    cohsm_result result;

    memset(&d, 0, sizeof d);
    memset(&s, 0, sizeof s);
    memset(&heap, 0, sizeof heap);
    memset(&model, 0, sizeof model);
    if (desc) d = *desc;
    log = cohsm__logger_of(&d.system, function);
    if (!mesh) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "mesh", "is NULL");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    result = cohsm__check_desc(&d, &log);
    if (result != COHSM_OK) return result;
    heap.allocator = cohsm__allocator_of(&d.system);
    result = cohsm__model_make(&model, &d, mesh, &heap, &s, &log);
    if (result == COHSM_ERR_MISMATCH)
        result = cohsm__refuse_value(&log, "desc.radius", (double)d.radius,
                                     "so large that the sphere about center holds the mesh");
    if (result == COHSM_OK) {
        result = cohsm__choose_sequence(&d, &model, &heap);
        if (result == COHSM_OK) result = cohsm__build_model(&d, &model, &heap, &maps, &s);
        (void)cohsm__log_build(&log, &d, result);
    }
    cohsm__soup_free(&model.soup, &heap);
    if (result == COHSM_OK) result = cohsm__lay_out_built(&maps, &d, heap.used, &s, &log);
    if (result != COHSM_OK) return result;
    *out = maps;
    if (stats) *stats = s;
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_build(const cohsm_desc *desc, const cohsm_mesh *mesh, cohsm_maps **out,
                                   cohsm_stats *stats)
{
    return cohsm__build_for("cohsm_build", desc, mesh, out, stats);
}

/* Measures the bytes a pixel of a build with this side, whose progress runs from..to. */
static cohsm_result cohsm__try_side(cohsm_desc d, const cohsm_mesh *mesh, uint32_t side, float from, float to,
                                    double *per_pixel)
{
    cohsm__step_system step;
    cohsm_maps *maps;
    cohsm_result result;

    cohsm__system_for_step(&d.system, &step, from, to);
    d.domain.side[0] = d.domain.side[1] = side;
    d.map_side = 64;
    d.pixel_begin = d.pixel_end = 0;
    d.layout = COHSM_LAYOUT_COMPACT;
    result = cohsm__build_for("cohsm_budget", &d, mesh, &maps, NULL);
    if (result != COHSM_OK) return result;
    *per_pixel = (double)(maps->head.lookup_words + maps->head.directory_words + maps->head.line_words) *
                 4.0 / (64 * 64);
    cohsm_free(maps);
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_budget(const cohsm_desc *desc, const cohsm_mesh *mesh, size_t bytes,
                                    uint32_t *side, uint32_t *map_side)
{
    cohsm_desc d;
    double coarse, fine, growth, pixel;
    double error, least = 0.0;
    uint32_t n, m, step, maps;
    cohsm_result result;
    cohsm__logger log;

    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    log = cohsm__logger_of(&d.system, "cohsm_budget");
    if (!mesh) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "mesh", "is NULL");
    if (!side) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "side", "is NULL");
    if (!map_side) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "map_side", "is NULL");
    if (d.domain.kind != COHSM_DOMAIN_DEFAULT && d.domain.kind != COHSM_DOMAIN_LATLONG &&
        d.domain.kind != COHSM_DOMAIN_OCTAHEDRAL)
        return cohsm__refuse_value(&log, "desc.domain.kind", (double)d.domain.kind, "LATLONG or OCTAHEDRAL");
    if (d.order == COHSM_ORDER_DEFAULT) d.order = COHSM_ORDER_HILBERT;
    result = cohsm__try_side(d, mesh, 16, 0.0f, 0.2f, &coarse);
    if (result == COHSM_OK) result = cohsm__try_side(d, mesh, 32, 0.2f, 1.0f, &fine);
    if (result != COHSM_OK) return result;
    growth = fine / coarse > 1.0 ? fine / coarse : 1.0;
    /* Sides are n, and half a doubling on 1.5 n. */
    for (n = 8, pixel = coarse / growth; n <= 2048; n *= 2, pixel *= growth)
        for (step = 2; step <= 3; step++)
            for (m = 16, maps = (n * step / 2u) * (n * step / 2u); m <= 1024; m += 16) {
                double size = pixel * (step == 3 ? 0.5 * (1.0 + growth) : 1.0) * m * m;
                size += 4.0 * (double)COHSM__HEADER_WORDS + (maps > 65536u ? 4.0 : 2.0) * maps;
                /* The lookup of the first chunk is part of pixel; this is that of the other chunks. */
                size += 4.0 * m * m * ((maps - 1u) / 65536u);
                if (size > 0.9 * (double)bytes) break;
                error = 0.0055 * 128.0 / (n * step / 2u) + 0.0185 * sqrt(128.0 / m);
                if (least > 0.0 && error >= least) continue;
                least = error;
                *side = n * step / 2u;
                *map_side = m;
            }
    if (least > 0.0) return COHSM_OK;
    cohsm__log_value(&log, "bytes", (double)bytes, "more: not even 64 maps of 16 x 16 pixels fit");
    return COHSM_ERR_LIMIT;
}

/* ==== src/csm/verify.h ==== */

/* ---- verify: every stored value against its interval ---- */

typedef struct cohsm__check {
    const cohsm_builder *builder;       /* for layers and intervals; its batch holds the views */
    const cohsm_maps    *maps;
    cohsm_report         part[COHSM__RANGES];
} cohsm__check;

/* Returns the stored depth at a view, and writes the first view after its segment. */
static uint32_t cohsm__segment_depth(const cohsm_maps *m, uint32_t pixel, uint32_t view, uint32_t *end)
{
    uint32_t begin = view & ~(COHSM__CHUNK - 1u),
             entry = m->lookup[(size_t)(view >> COHSM__CHUNK_BITS) * m->range + pixel];
    uint32_t b = 0, count;
    uint32_t n, j, k;
    uint32_t at, bucket;
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

/* Compares a range of pixels in all views of the batch, pixel by pixel, so that a list is read once for many
   views. */
static void cohsm__verify_task(void *context, size_t index)
{
    cohsm__check *k = (cohsm__check *)context;
    const cohsm_builder *b = k->builder;
    cohsm_report *r = &k->part[index];
    uint32_t p, i, view, end;
    uint32_t lo, hi, z = 0;

    memset(r, 0, sizeof *r);
    for (p = b->ranges[index].begin; p < b->ranges[index].end; p++) {
        const uint16_t *layers = b->batch + (size_t)(b->desc.pixel_begin + p) * b->keep;
        for (i = 0, end = 0; i < b->batch_count; i++, layers += b->batch_size) {
            view = b->batch_begin + i;
            if (k->maps->trays.lines) z = cohsm__stored_depth(k->maps, p, view);
            else if (view >= end) z = cohsm__segment_depth(k->maps, p, view, &end);
            r->empty += (uint64_t)cohsm__interval(b, layers, &lo, &hi);
            r->entries++;
            if ((z >= lo && z <= hi) || (r->wrong++ && view >= r->first_view)) continue;
            r->first_view = view;
            r->first_pixel = p + b->desc.pixel_begin;
        }
    }
}

/* Returns the desc that a block was built with, with the caller's system. */
static cohsm_desc cohsm__desc_of(const cohsm_maps *m, const cohsm_system *system)
{
    const cohsm__header *h = &m->head;
    cohsm_desc d;

    memset(&d, 0, sizeof d);
    if (system) d.system = *system;
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
    d.map_side = h->map_side;
    d.layers = (cohsm_layers)h->layers;
    d.order = (cohsm_order)h->order;
    d.orientation = (cohsm_orientation)h->orientation;
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

    if (!cohsm__job_begin(&job, b, soup, NULL)) return COHSM_ERR_ALLOC;
    check.builder = b;
    check.maps = maps;
    for (; b->batch_begin < b->head.view_count; b->batch_begin += b->batch_count) {
        if (b->desc.system.progress &&
            b->desc.system.progress(b->desc.system.user, (float)b->batch_begin / (float)b->head.view_count)) {
            cohsm__job_end(&job);
            return COHSM_ERR_CANCELLED;
        }
        b->batch_count = cohsm__min_u32(b->batch_views, b->head.view_count - b->batch_begin);
        cohsm__draw_batch(&job);
        cohsm__run_tasks(&b->desc.system, COHSM__RANGES, cohsm__verify_task, &check);
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
    cohsm__job_end(&job);
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_verify(const cohsm_maps *maps, const cohsm_system *system,
                                    const cohsm_mesh *mesh, cohsm_report *out)
{
    cohsm_desc d;
    cohsm_stats stats;
    cohsm__counted_heap heap;
    cohsm__model model;
    cohsm_report report;
    cohsm_builder *b;
    cohsm__logger log = cohsm__logger_of(system, "cohsm_verify");
    cohsm_result result;

    if (!maps) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "maps", "is NULL");
    if (!mesh) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "mesh", "is NULL");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (system && !cohsm__system_valid(system))
        return cohsm__refuse(&log, COHSM_ERR_DESC, "system.allocator", "has one function of the two");
    d = cohsm__desc_of(maps, system);
    memset(&stats, 0, sizeof stats);
    memset(&heap, 0, sizeof heap);
    memset(&model, 0, sizeof model);
    memset(&report, 0, sizeof report);
    heap.allocator = cohsm__allocator_of(&d.system);
    result = cohsm__model_make(&model, &d, mesh, &heap, &stats, &log);
    if (result == COHSM_ERR_MISMATCH) cohsm__log_text(&log, "mesh", "reaches out of the sphere of the maps");
    if (result == COHSM_OK) {
        result = cohsm__builder_make(&d, &heap, &b);
        if (result == COHSM_OK) {
            result = cohsm__verify_views(b, maps, &model.soup, &report);
            cohsm__drop_builder(b, &heap);
        }
        (void)cohsm__log_build(&log, &d, result);
    }
    cohsm__soup_free(&model.soup, &heap);
    if (result == COHSM_OK) *out = report;
    return result;
}

/* ==== src/csm/shards.h ==== */

/* ---- shards: parts of one build, by ranges of pixels, put together ---- */

/* Says whether two shards are of one build: they then differ in their pixels, lengths and counts only. */
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

/* Lays the lists of all shards one after the other. Returns 0 if the caller cancelled. */
static int cohsm__lay_shards(const cohsm_maps *const *shards, size_t count, cohsm__part part,
                             cohsm__layout *l, uint32_t *lookup)
{
    uint32_t chunk, chunks = cohsm__chunks(&shards[0]->head), p, dry_entry;
    size_t i, done = 0, lists = (size_t)shards[count - 1u]->head.pixel_end * chunks;

    for (chunk = 0; chunk < chunks; chunk++)
        for (i = 0; i < count; i++) {
            const cohsm_maps *s = shards[i];
            for (p = 0; p < s->range; p++) {
                uint32_t entry = s->lookup[(size_t)chunk * s->range + p],
                         *at = lookup ? lookup++ : &dry_entry, blocks;
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

static cohsm_result cohsm__join_shards(const cohsm_maps *const *shards, size_t count, cohsm__header *h,
                                       const cohsm__allocator *a, const cohsm__part *part, cohsm_maps **out)
{
    cohsm__layout layout;
    cohsm__memory block;
    uint32_t *lookup;
    cohsm_result result;

    memset(&layout, 0, sizeof layout);
    if (!cohsm__lay_shards(shards, count, cohsm__part_of(part, 0.0f, 0.5f), &layout, NULL))
        return COHSM_ERR_CANCELLED;
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
    cohsm__seal_block(block.words, h);
    return cohsm__maps_make(a, block, out);
}

COHSM_DEF cohsm_result cohsm_merge(const cohsm_maps *const *shards, size_t count, const cohsm_system *system,
                                   cohsm_maps **out)
{
    cohsm__allocator a;
    cohsm__part part, joined;
    cohsm__wish wish;
    cohsm_maps *maps = NULL;
    cohsm_result result;
    uint64_t segments = 0;
    cohsm__header h;
    uint32_t next = 0;
    size_t i;
    cohsm__logger log = cohsm__logger_of(system, "cohsm_merge");

    if (!shards) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "shards", "is NULL");
    if (!count) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "count", "is 0; it must be 1 or more");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (!cohsm__services_of(system, &log, &a, &part)) return COHSM_ERR_DESC;
    for (i = 0; i < count; i++) {
        if (!shards[i]) {
            cohsm__log_element_text(&log, "shards", i, "is NULL");
            return COHSM_ERR_ARGUMENT;
        }
        if (!cohsm__same_build(shards[0], shards[i]))
            return cohsm__refuse(&log, COHSM_ERR_MISMATCH, "shards", "are not all of one desc and mesh");
        if (shards[i]->head.pixel_begin != next) {
            cohsm__log_element(&log, "shards", i, "begins with pixel", (double)shards[i]->head.pixel_begin,
                               "where the shard before ends, 0 for the first");
            return COHSM_ERR_MISMATCH;
        }
        next = shards[i]->head.pixel_end;
        segments += (uint64_t)shards[i]->head.segments_high << 32 | shards[i]->head.segments_low;
    }
    h = shards[0]->head;
    if (next != h.map_side * h.map_side) {
        cohsm__log_element(&log, "shards", count - 1, "ends at pixel", (double)next,
                           "map_side^2 for the last");
        return COHSM_ERR_MISMATCH;
    }
    h.pixel_end = next;
    h.lookup_words = next * cohsm__chunks(&h);
    h.segments_low = (uint32_t)(segments & 0xffffffffu);
    h.segments_high = (uint32_t)(segments >> 32);
    wish.layout = shards[0]->trays.lines ? COHSM_LAYOUT_FAST : COHSM_LAYOUT_COMPACT;
    wish.bytes = 0;
    wish.system = system;
    joined = cohsm__part_of(&part, 0.0f, wish.layout == COHSM_LAYOUT_FAST ? 0.5f : 1.0f);
    result = cohsm__join_shards(shards, count, &h, &a, &joined, &maps);
    part = cohsm__part_of(&part, 0.5f, 1.0f);
    if (result == COHSM_ERR_LIMIT) cohsm__log_text(&log, "shards", "make maps of 4 GiB or more together");
    if (result == COHSM_OK) {
        result = cohsm__lay_out_opened(maps, &wish, part, out);
        cohsm__log_layout(&log, "the layout of shards[0]", result);
    }
    return cohsm__log_result(&log, result);
}

/* ==== src/csm/open.h ==== */

/* ---- open: blocks of files, which may be hostile ---- */

static int cohsm__header_sound(const cohsm__header *h)
{
    cohsm_domain_kind kind = (cohsm_domain_kind)h->domain;
    uint64_t n = (uint64_t)h->side[0] * h->side[1], total;
    uint32_t order;
    size_t i;

    if (h->domain == 0 || h->domain >= COHSM_DOMAIN_COUNT || h->layers == 0 ||
        h->layers >= COHSM_LAYERS_COUNT || h->order == 0 || h->order >= COHSM_ORDER_COUNT ||
        h->orientation == 0 || h->orientation >= COHSM_ORIENTATION_COUNT)
        return 0;
    for (i = 0; i < 3; i++)
        if (h->side[i] == 0 || h->side[i] > (cohsm__has_table(h->domain) ? 1u << 24 : 4096u)) return 0;
    if (n > 1u << 24 || n * h->side[2] > 1u << 24 || n * h->side[2] != h->map_count) return 0;
    if (h->positional > 1 || h->self_only > 1 || h->view_count != h->map_count * (h->positional ? 6u : 1u))
        return 0;
    if (kind == COHSM_DOMAIN_LATLONG || kind == COHSM_DOMAIN_OCTAHEDRAL) {
        if (h->positional || h->side[2] != 1) return 0;
    } else if (!cohsm__has_table(h->domain) && !h->positional) return 0;
    if (h->dimensions != cohsm__dimensions(kind, h->side)) return 0;
    if (h->map_side < 4 || h->map_side > 1024 || h->depth_bits < 4 || h->depth_bits > 8) return 0;
    if (h->pixel_begin >= h->pixel_end || h->pixel_end > h->map_side * h->map_side) return 0;
    order = h->order != COHSM_ORDER_HILBERT ? 0
            : h->map_count <= 65536         ? (h->map_count + 1) / 2
                                            : h->map_count;
    if (h->order_words != order || h->location_words != (cohsm__has_table(h->domain) ? 4 * h->map_count : 0))
        return 0;
    total = (uint64_t)(h->pixel_end - h->pixel_begin) * cohsm__chunks(h);
    if (total != h->lookup_words || h->line_words % COHSM__BLOCK_WORDS != COHSM__PADDING) return 0;
    total += (uint64_t)COHSM__HEADER_WORDS + order + h->location_words + h->directory_words;
    if (total % COHSM__BLOCK_WORDS) return 0;
    total += h->line_words;
    if (total != h->words || total > COHSM__MOST_WORDS) return 0;
    if (!cohsm__floats_finite(h) || !(h->open_thickness > 0.0f && h->open_thickness <= 1024.0f)) return 0;
    if (!cohsm__radius_usable(h->radius) || (h->positional && !(h->depth_far > 0.0f))) return 0;
    for (i = 0; i < sizeof h->reserved / sizeof h->reserved[0]; i++)
        if (h->reserved[i]) return 0;
    return 1;
}

/* Says whether a block is sound within the words that are left of its line: its parts lie inside it, and its
   segments rise and stay below `views`, counted from the block's first view. */
static int cohsm__block_sound(const uint32_t *block, uint32_t left, uint32_t views)
{
    uint32_t n, exact = 0, j, at;
    uint32_t bucket = 0, low, offset, previous = 0;
    uint32_t size, code;
    uint64_t marks;
    cohsm__fields f;

    if (left < 3) return 0;
    marks = cohsm__marks(block);
    n = cohsm__popcount(marks);
    f = cohsm__block_fields(block, n);
    if (!(marks & 1u) || f.bits == 0 || f.exact_at > COHSM__BLOCK_BITS || (f.exact_at + 31u) / 32u > left)
        return 0;
    if ((block[0] >> 12 & 15u) > COHSM__WIDEST && f.palette == 0) return 0;
    for (j = 0; j < n; j++) {
        code = cohsm__bits(block, f.codes_at + j * f.bits, f.bits);
        if (code + 1u == 1u << f.bits) exact++;
        else if (f.palette ? code >= f.palette : code + 2u < 1u << f.bits && (block[0] & 255u) + code > 254u)
            return 0;
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
    /* Every bucket that a search may ask for must have its mark. */
    return ((views - 1u) >> f.k) + n <= COHSM__MARKS;
}

/* Says whether the list of an entry is sound. *unnamed counts the words of directories that no entry before
   has named, and is reduced by those of this list. Lists share no words, so all checks together take time
   that is linear in the file, even if all entries name the longest list. */
static int cohsm__list_sound(const cohsm_maps *m, uint32_t entry, uint32_t views, uint32_t *unnamed)
{
    const uint32_t *directory = m->directories + entry;
    uint32_t lines = m->head.line_words / COHSM__BLOCK_WORDS;
    uint32_t left = m->head.directory_words - entry, blocks, tail, b;
    uint32_t first = 0, next;

    if (left < 2) return 0;
    blocks = cohsm__block_count(directory);
    tail = directory[1] >> 16;
    if (blocks == 0 || 2u + blocks / 2u > cohsm__min_u32(left, *unnamed)) return 0;
    *unnamed -= 2u + blocks / 2u;
    if (directory[0] > lines || blocks - 1u > lines - directory[0]) return 0;
    if (tail >> 4 > directory[0] || directory[0] - (tail >> 4) >= lines) return 0;
    for (b = 0; b < blocks; b++) {
        next = b + 1 < blocks ? cohsm__block_first(directory, b + 1) : views;
        if (next <= first || next > views) return 0;
        if (!cohsm__block_sound(cohsm__block_at(directory, m->lines, b),
                                b + 1 < blocks ? (uint32_t)COHSM__BLOCK_WORDS
                                               : COHSM__BLOCK_WORDS - (tail & 15u),
                                next - first))
            return 0;
        first = next;
    }
    return 1;
}

static cohsm_result cohsm__check_lists(const cohsm_maps *m, cohsm__part part)
{
    uint32_t entry, views, chunk, chunks = cohsm__chunks(&m->head);
    uint32_t unnamed = m->head.directory_words;
    size_t i;

    for (i = 0; i < m->head.lookup_words; i++) {
        if (cohsm__cancelled(&part, i, m->head.lookup_words, COHSM__LISTS_COPIED)) return COHSM_ERR_CANCELLED;
        chunk = (uint32_t)(i / m->range);
        views = chunk + 1 < chunks ? COHSM__CHUNK : m->head.view_count - chunk * COHSM__CHUNK;
        entry = m->lookup[i];
        if (entry & COHSM__CONSTANT ? entry & 0x7fff0000u
                                    : entry >= m->head.directory_words ||
                                          !cohsm__list_sound(m, entry, views, &unnamed))
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
        if (!cohsm__v3_finite(cohsm__v3_load(l)) || l[3] != (m->head.positional ? 1.0f : 0.0f)) return 0;
    return 1;
}

/* Makes maps of a block of a file after checking everything in it. Takes the memory over, or frees it if this
   fails. */
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

/* ==== src/csm/pack_coder.h ==== */

/* ---- pack: the entropy-coded file ---- */

/* The packed file consists of

     4 words       "DCSP"; the format; the bytes of the file; the number of segments in the longest list
     the header of the plain block, and its locations, as they stand there
     the lists, coded; or, if the fourth word is 0, the rest of the plain block as it is

   The order table is left out, since it follows from the header. A list is coded as the first views of its
   segments, their depths, and the number of segments in each block. Everything else in the list follows from
   these, because blocks are written in one way only (see cohsm__plan_block). Every decision is a bit, coded
   with the adaptive probability of its context; contexts are made from the lists of the pixels to the left,
   above, and above to either side. The bits go through a range coder (Martin, "Range encoding", 1979). */

enum {
    COHSM__PACK_FORMAT = 1,
    COHSM__PACK_HEADER = 16,            /* bytes */
    COHSM__PACK_MULTIPLE = 64           /* of the file's size: the most memory that opening asks for */
};

typedef uint16_t cohsm__prob;           /* of a 1, in 1/65536 */

/* An encoder or a decoder. Both run the same lines of code, so that they cannot differ: each step takes the
   bit to encode, which a decoder ignores, and returns the bit that was encoded or decoded. */
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

/* Codes a 1, to which the upper part of the range belongs; the lower part, which is `zero` long, belongs to a
   0. */
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

/* Codes a bit by an adaptive probability, which stays within 31..65505 of 65536, so that neither part of the
   range is ever empty. */
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

/* Codes a number of so many bits, high bits first. Each sequence of bits that went before has a probability
   of its own. */
static uint32_t cohsm__code_tree(cohsm__coder *c, cohsm__prob *p, uint32_t bits, uint32_t value)
{
    uint32_t node = 1;
    while (bits--) node = node << 1 | cohsm__code_bit(c, p + node, value >> bits & 1u);
    for (bits = 1; bits <= node >> 1; bits <<= 1) {}
    return node - bits;
}

/* Codes bits that are 0 or 1 with equal probability. */
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

/* Returns the number of bits of x: 0 for 0, 1 for 1, 2 for 2 and 3, 3 for 4 to 7, ... */
static uint32_t cohsm__bit_length(uint32_t x)
{
    x |= x >> 1;
    x |= x >> 2;
    x |= x >> 4;
    x |= x >> 8;
    return cohsm__popcount(x | x >> 16);
}

enum { COHSM__NUMBER = 64 };                    /* probabilities that cohsm__code_number needs */

/* Codes a number below 2^31: the count of its bits, then the bits below the leading one, of which only the
   first has a probability. */
static uint32_t cohsm__code_number(cohsm__coder *c, cohsm__prob *p, uint32_t value)
{
    uint32_t bits = cohsm__code_tree(c, p, 5, cohsm__bit_length(value)), low;
    if (bits < 2) return bits;
    low = cohsm__code_bit(c, p + 32 + bits, value >> (bits - 2u) & 1u) << (bits - 2u);
    if (bits > 2) low |= cohsm__code_raw(c, bits - 2u, value);
    return 1u << (bits - 1u) | low;
}

/* ==== src/csm/pack_lists.h ==== */

/* ---- pack: a list as its neighbours foresee it ---- */

/* A list that is taken apart into its segments. */
typedef struct cohsm__strip {
    uint32_t        count;              /* segments; 0: there is no such pixel */
    cohsm__segment *s;                  /* lo = hi is the grid value; of an exact depth lo is that depth, and
                                           hi the grid value at or below it */
    uint32_t       *breaks;             /* bit COHSM__MARGIN + i is set if a segment begins at view i > 0 */
} cohsm__strip;

enum { COHSM__LEFT, COHSM__UP, COHSM__UP_LEFT, COHSM__UP_RIGHT, COHSM__SELF, COHSM__STRIPS };
enum { COHSM__MARGIN = 32, COHSM__REACH = 2, COHSM__NEAR = 1 << (2 * COHSM__REACH + 1), COHSM__RUNS = 8,
       COHSM__BREAK_WORDS = (COHSM__MARGIN + 65536 + COHSM__REACH) / 32 + 2 };

typedef struct cohsm__odds {            /* the adaptive probabilities of all bits, by their contexts */
    cohsm__prob hot[COHSM__NEAR * COHSM__NEAR * 3 * COHSM__RUNS];
    cohsm__prob cold[32 * 32], cold_length[32 * COHSM__NUMBER];
    cohsm__prob exact[3], repeat[128], left[64], up[8];
    cohsm__prob below[16], error[32 * COHSM__NUMBER];
    cohsm__prob more[16 * 64];
    uint32_t breaks[COHSM__STRIPS][COHSM__BREAK_WORDS];     /* of the strips */
} cohsm__odds;

typedef struct cohsm__packer {          /* the work on one block, of encoder or decoder */
    cohsm__coder  c;
    cohsm__odds *m;
    cohsm__strip  strip[COHSM__STRIPS];         /* of the pixel at hand and its neighbours */
    cohsm__segment *segments;                   /* memory of the strips, then of taken */
    uint32_t      longest, width, views;        /* segments of the longest list; words of strip.breaks; views
                                                   of the chunk */
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

/* Appends the segments of one block to a strip. */
static void cohsm__strip_block(const cohsm__packer *p, cohsm__strip *t, const uint32_t *block, uint32_t first)
{
    uint64_t marks = cohsm__marks(block);
    uint32_t n = cohsm__popcount(marks), bucket = 0;
    uint32_t j, code, exact_at;
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

/* Where the lists of a block are. A decoder reads there the lists that it wrote before. */
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

/* Reads a list into a strip; taken, which may be NULL, receives how many segments each block has. */
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

/* Returns 33 bits or more from any position, which is more than any field needs. */
static uint64_t cohsm__window(const uint32_t *words, uint32_t bit)
{
    const uint32_t *w = words + (bit >> 5);
    return (w[0] | (uint64_t)w[1] << 32) >> (bit & 31u);
}

/* Returns the breaks of a strip from view - COHSM__REACH on, as bits, 33 of them or more. */
static uint64_t cohsm__breaks_near(const cohsm__strip *t, uint32_t view)
{
    return cohsm__window(t->breaks, COHSM__MARGIN + view - COHSM__REACH);
}

/* Returns the first view at or after this one that has a break of either neighbour within reach, at most
   p->views. */
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

/* Codes one by one whether the segment ends at a view, for views next to a break of the left or the upper
   list. Returns the first view that is not next to one, or the one where the segment ends, with *ended. */
static uint32_t cohsm__code_hot(cohsm__packer *p, uint32_t first, uint32_t view, uint32_t next, int *ended)
{
    uint64_t left = cohsm__breaks_near(&p->strip[COHSM__LEFT], view);
    uint64_t up = cohsm__breaks_near(&p->strip[COHSM__UP], view);
    uint64_t right = cohsm__breaks_near(&p->strip[COHSM__UP_RIGHT], view);
    uint32_t stop = cohsm__min_u32(p->views, view + 33u - 2 * COHSM__REACH);
    uint32_t run = cohsm__bit_length(view - first), l, u, r;
    cohsm__prob *odds;

    for (; view < stop; view++, left >>= 1, up >>= 1, right >>= 1) {
        l = (uint32_t)left & (COHSM__NEAR - 1u);
        u = (uint32_t)up & (COHSM__NEAR - 1u);
        r = (uint32_t)right & (COHSM__NEAR - 1u);
        if (!(l | u)) break;
        if ((view - first) >> run) run++;
        r = r >> COHSM__REACH & 1u ? 2u : r ? 1u : 0u;
        odds = p->m->hot + ((l * COHSM__NEAR + u) * 3u + r) * COHSM__RUNS + cohsm__min_u32(run, COHSM__RUNS) -
               1u;
        *ended = (int)cohsm__code_bit(&p->c, odds, view == next);
        if (*ended) break;
    }
    return view;
}

/* Codes where the segment that began at first ends, and returns that view. Views near a break of a neighbour
   are coded one by one. For a stretch without such views the function codes whether the segment ends in the
   stretch, and if so, where. */
static uint32_t cohsm__code_next(cohsm__packer *p, uint32_t first, uint32_t next)
{
    uint32_t view = first + 1u, gap, hot;
    int ended = 0;

    for (;;) {
        view = cohsm__code_hot(p, first, view, next, &ended);
        if (ended || view >= p->views) return view;
        hot = cohsm__next_hot(p, view);
        if (hot == view) continue;
        gap = cohsm__bit_length(hot - view);
        if (cohsm__code_bit(&p->c, p->m->cold + 32 * gap + cohsm__bit_length(view - first), next < hot)) {
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

/* Returns the grid value that a strip has at a view; the views of successive calls rise. */
static uint32_t cohsm__strip_value(const cohsm__strip *t, uint32_t *at, uint32_t view, uint32_t otherwise)
{
    if (!t->count) return otherwise;
    while (*at + 1u < t->count && t->s[*at + 1u].first <= view) ++*at;
    return t->s[*at].hi;
}

/* Returns the median of left, up and left + up - corner, which continues an edge, or else a plane, through
   three known neighbours. */
static uint32_t cohsm__predict_value(uint32_t left, uint32_t up, uint32_t corner)
{
    uint32_t least = cohsm__min_u32(left, up), most = cohsm__max_u32(left, up);
    return corner >= most ? least : corner <= least ? most : left + up - corner;
}

/* The numbers that are known when the value of a segment is coded: the values of the neighbours at the
   segment's middle, those of the two segments before, whether earlier values were repeated (bits of history),
   and the views of the segment. */
typedef struct cohsm__around { uint32_t left, up, corner, before[2], history, run; } cohsm__around;

/* Codes a value by asking in turn whether it is the value before last, as where two surfaces flicker, or that
   of the left or the upper neighbour, and else by a correction of the prediction. */
static uint32_t cohsm__code_value(cohsm__packer *p, const cohsm__around *a, uint32_t value)
{
    cohsm__odds *m = p->m;
    cohsm__coder *c = &p->c;
    uint32_t last = a->before[1], h = a->history;
    uint32_t guess, below, error, spread;

    if (cohsm__code_bit(c,
                        m->repeat + ((a->left == last ? 1u : 0u) | (a->up == last ? 2u : 0u) | (h & 7u) << 2 |
                                     (a->run == 1 ? 32u : 0u) | (a->before[0] == last ? 64u : 0u)),
                        value == last))
        return last;
    if (a->left != last && cohsm__code_bit(c,
                                           m->left + ((a->up == a->left ? 1u : 0u) | (h & 14u) << 1 |
                                                      (a->before[0] == a->left ? 32u : 0u)),
                                           value == a->left))
        return a->left;
    if (a->up != last && a->up != a->left && cohsm__code_bit(c, m->up + (h & 7u), value == a->up))
        return a->up;
    guess = cohsm__predict_value(a->left, a->up, a->corner);
    spread = cohsm__bit_length(cohsm__max_u32(a->left, a->up) - cohsm__min_u32(a->left, a->up));
    below = cohsm__code_bit(c, m->below + spread, value < guess);
    error = cohsm__code_number(c, m->error + COHSM__NUMBER * (2 * spread + below),
                               below ? guess - value : value - guess);
    return below ? guess - cohsm__min_u32(error, guess) : guess + cohsm__min_u32(error, p->grid.top - guess);
}

static void cohsm__code_values(cohsm__packer *p)
{
    cohsm__strip *t = &p->strip[COHSM__SELF];
    uint32_t at[COHSM__SELF], i;
    uint32_t end, middle, exact = 0;
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

/* ==== src/csm/pack_blocks.h ==== */

/* ---- pack: lists cut into blocks again ---- */

/* Returns how many of the segments fit into a block without a palette, as cohsm__plan_take would find if each
   segment had only the value that was stored. */
static uint32_t cohsm__count_fitting(const cohsm__segment *s, uint32_t count, uint32_t grid, uint32_t views)
{
    uint32_t n, least = grid, most = 0, exact = 0;
    uint32_t k = 0, bits = 2, span;

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

/* Codes how many segments each block takes. They may be more than cohsm__count_fitting finds by their values,
   since the builder went by intervals, in which it could choose the values. */
static uint32_t cohsm__code_blocks(cohsm__packer *p)
{
    const cohsm__strip *t = &p->strip[COHSM__SELF];
    uint32_t i, n, blocks, left;

    for (i = 0, blocks = 0; i < t->count; i += p->taken[blocks++]) {
        left = t->count - i;
        n = cohsm__count_fitting(t->s + i, left, p->grid.top, p->views);
        left = cohsm__min_u32(left, COHSM__MARKS);
        if (n < left)
            n += cohsm__code_tree(&p->c, p->m->more + 64 * (n / 4u), 6, p->c.out ? p->taken[blocks] - n : 0);
        p->taken[blocks] = (uint8_t)cohsm__min_u32(n, left);
    }
    return blocks;
}

/* Makes the plan of a block of exactly n segments, as cohsm__plan_block would; `last` says that it is a tail.
   Returns 0 if they do not fit. */
static int cohsm__plan_exactly(cohsm__plan *plan, const cohsm__segment *s, uint32_t n,
                               const cohsm__grid *grid, uint32_t end, int last)
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
    if (last && !plan->palette && cohsm__plan_palette(&other, s, grid) && other.size < plan->size)
        *plan = other;
    return 1;
}

/* Writes the decoded list as the builder would keep it, see cohsm__write_list. Returns 0 if no builder wrote
   this. */
static int cohsm__strip_write(const cohsm__packer *p, uint32_t blocks)
{
    const cohsm__segment *s = p->strip[COHSM__SELF].s;
    uint32_t count = p->strip[COHSM__SELF].count, i, n, end;
    uint32_t *block = p->list + (blocks + 1u) / 2u;
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

/* Lays the decoded list where it belongs. Returns 0 if there is no room, or if no builder wrote this list. */
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
    if (dry.directory_words > h->directory_words || dry.line_count > h->line_words / COHSM__BLOCK_WORDS)
        return 0;
    cohsm__lay_raw(l, entry, p->list);
    return 1;
}

/* Moves the strips of the neighbours on by one pixel; the strip of the pixel at hand can be written again. */
static void cohsm__slide_strips(cohsm__packer *p)
{
    cohsm__strip *t = p->strip, spare = t[COHSM__UP_LEFT];
    t[COHSM__UP_LEFT] = t[COHSM__UP];
    t[COHSM__UP] = t[COHSM__UP_RIGHT];
    t[COHSM__UP_RIGHT] = t[COHSM__LEFT];
    t[COHSM__LEFT] = t[COHSM__SELF];
    t[COHSM__SELF] = spare;
}

/* Reads the strips around a pixel of the range; index is that of its lookup entry. Within a row all but the
   upper right strip are there already. */
static void cohsm__look_around(cohsm__packer *p, const cohsm__header *h, uint32_t pixel, size_t index,
                               const cohsm__lists *l)
{
    uint32_t m = h->map_side, x = (h->pixel_begin + pixel) % m;
    cohsm__strip *t = p->strip;

    cohsm__slide_strips(p);
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

/* ==== src/csm/pack.h ==== */

/* ---- pack: maps to packed files, and back ---- */

/* Codes all lists of a block. The decoder writes the lists and the lookup into out, which is words with its
   header. Returns COHSM_ERR_FORMAT if no builder wrote this, or if there is no room for it. */
static cohsm_result cohsm__code_lists(cohsm__packer *p, const cohsm__header *h, const uint32_t *words,
                                      uint32_t *out, cohsm__part part)
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

/* Returns how many segments the longest list has. */
static uint32_t cohsm__longest_list(const cohsm_maps *m)
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

/* Returns the bytes of memory that the work on a block takes: strips, and the order table's cells. */
static uint64_t cohsm__pack_work(const cohsm__header *h, uint32_t longest)
{
    return (uint64_t)longest * (COHSM__STRIPS * sizeof(cohsm__segment) + 1) +
           4 * (uint64_t)cohsm__list_bound(longest) + (h->order_words ? 4 * (uint64_t)h->map_count : 0);
}

static int cohsm__packer_make(cohsm__packer *p, const cohsm__allocator *a, const cohsm__header *h,
                              uint32_t longest)
{
    cohsm__prob *probs;
    size_t i;

    memset(p, 0, sizeof *p);
    p->longest = longest;
    p->grid = cohsm__grid_of(h->depth_bits, h->map_side);
    p->m = (cohsm__odds *)cohsm__alloc(a, sizeof *p->m);
    p->segments =
        (cohsm__segment *)cohsm__alloc_array(a, longest, COHSM__STRIPS * sizeof(cohsm__segment) + 1);
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

/* Puts the words that are not coded in their places, and makes the order table. */
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

/* Says whether a packed file of so many bytes can have this header, which is sound, and this longest list. */
static int cohsm__packed_sound(const cohsm__header *h, uint32_t longest, size_t size)
{
    return longest <= COHSM__CHUNK && longest <= h->view_count && cohsm__pack_head(h) <= size &&
           4 * (uint64_t)h->words + cohsm__pack_work(h, longest) <= COHSM__PACK_MULTIPLE * (uint64_t)size;
}

/* Unpacks a packed file of 16 bytes or more whose magic is known; all else in it may be hostile. It asks for
   at most COHSM__PACK_MULTIPLE bytes of memory a byte of file, and 256 KB for the probabilities and the
   object. */
static cohsm_result cohsm__unpack(const uint8_t *data, size_t size, const cohsm__allocator *a,
                                  const cohsm__part *part, cohsm_maps **out)
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
    if (!cohsm__header_sound(&h) || !cohsm__packed_sound(&h, longest, size)) return COHSM_ERR_FORMAT;
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

/* Codes maps into data; returns COHSM_ERR_FORMAT if the code would reach room. The file is filled up with
   zeros to the size that opening has to see before it asks for memory. */
static cohsm_result cohsm__pack_coded(cohsm__packer *p, const cohsm_maps *m, const cohsm__part *part,
                                      uint8_t *data, size_t room, size_t *size)
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

/* Returns COHSM_ERR_FORMAT if data does not unpack to these maps: they are sound, but our builder did not
   write them. */
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

COHSM_DEF cohsm_result cohsm_pack(const cohsm_maps *maps, const cohsm_system *system, void **data,
                                  size_t *bytes)
{
    cohsm__allocator a;
    cohsm__part part;
    cohsm__packer p;
    uint8_t *big, *packed = NULL;
    size_t plain, coded = 0;
    uint64_t whole;
    cohsm_result result;
    cohsm__logger log = cohsm__logger_of(system, "cohsm_pack");

    if (!maps) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "maps", "is NULL");
    if (!data) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "data", "is NULL");
    if (!bytes) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "bytes", "is NULL");
    if (!cohsm__services_of(system, &log, &a, &part)) return COHSM_ERR_DESC;
    whole = 4 * (uint64_t)maps->head.words + COHSM__PACK_HEADER;
    if (whole > 0xffffffffu) return cohsm__refuse(&log, COHSM_ERR_LIMIT, "maps", "take 4 GiB or more");
    plain = (size_t)whole;
    big = (uint8_t *)cohsm__alloc(&a, plain);
    if (!big) return cohsm__log_result(&log, COHSM_ERR_ALLOC);
    if (cohsm__packer_make(&p, &a, &maps->head, cohsm__longest_list(maps)))
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
    if (result != COHSM_OK) return cohsm__log_result(&log, result);
    *data = packed;
    *bytes = coded;
    return COHSM_OK;
}

/* ==== src/csm/files.h ==== */

/* ---- files: the block as bytes, and back ---- */

COHSM_DEF const void *cohsm_data(const cohsm_maps *m, size_t *bytes)
{
    if (!m) return NULL;
    if (bytes) *bytes = 4 * (size_t)m->head.words;
    return m->words;
}

COHSM_DEF const void *cohsm_fast_data(const cohsm_maps *m, size_t *bytes)
{
    if (bytes) *bytes = m ? m->trays.data_bytes : 0;
    return m ? m->trays.data : NULL;
}

COHSM_DEF cohsm_result cohsm_write(const cohsm_maps *m, void *memory, size_t memory_bytes)
{
    cohsm__logger log = cohsm__logger_of_maps(m, "cohsm_write");
    uint32_t i;

    if (!m) return COHSM_ERR_ARGUMENT;
    if (!memory) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "memory", "is NULL");
    if (memory_bytes < 4 * (size_t)m->head.words) {
        cohsm__log_value(&log, "memory_bytes", (double)memory_bytes, "cohsm_info.bytes or more");
        return COHSM_ERR_MEMORY;
    }
    for (i = 0; i < m->head.words; i++) cohsm__put_u32((uint8_t *)memory + 4 * (size_t)i, m->words[i]);
    return COHSM_OK;
}

static cohsm_result cohsm__open_file(const uint8_t *file, size_t bytes, const cohsm__allocator *a,
                                     const cohsm__part *part, cohsm_maps **out)
{
    if (bytes < 16) return COHSM_ERR_FORMAT;
#ifndef COHSM_WITHOUT_PACK
    if (cohsm__get_u32(file) == COHSM__PACK_MAGIC) return cohsm__unpack(file, bytes, a, part, out);
#else
    if (cohsm__get_u32(file) == COHSM__PACK_MAGIC) return COHSM_ERR_MISMATCH;
#endif
    if (cohsm__get_u32(file) != COHSM__MAGIC) return COHSM_ERR_FORMAT;
    if (cohsm__get_u32(file + 4) != COHSM__FORMAT) return COHSM_ERR_VERSION;
    return cohsm__open_plain(file, bytes, a, part, out);
}

/* Opens a file and lays the maps out as wanted. If trays may be wanted, the second half of the progress is
   theirs. */
static cohsm_result cohsm__open_wished(const void *data, size_t bytes, const cohsm__wish *wish,
                                       const cohsm__logger *log, cohsm_maps **out)
{
    cohsm__allocator a;
    cohsm__part part, opening;
    cohsm_maps *maps = NULL;
    cohsm_result result;

    if (!data) return cohsm__refuse(log, COHSM_ERR_ARGUMENT, "data", "is NULL");
    if (!out) return cohsm__refuse(log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (!cohsm__services_of(wish->system, log, &a, &part)) return COHSM_ERR_DESC;
    opening = cohsm__part_of(&part, 0.0f, wish->layout == COHSM_LAYOUT_COMPACT ? 1.0f : 0.5f);
    result = cohsm__open_file((const uint8_t *)data, bytes, &a, &opening, &maps);
    part = cohsm__part_of(&part, 0.5f, 1.0f);
    if (result == COHSM_OK) result = cohsm__lay_out_opened(maps, wish, part, out);
    if (result == COHSM_ERR_FORMAT) cohsm__log_text(log, "data", "is no file of csm.h, or a damaged one");
    if (result == COHSM_ERR_VERSION) cohsm__log_text(log, "data", "is a file of an unknown version");
    if (result == COHSM_ERR_MISMATCH)
        cohsm__log_text(log, "data", "is a packed file, and this csm.h was joined without pack");
    cohsm__log_layout(log, "layout", result);
    return cohsm__log_result(log, result);
}

COHSM_DEF cohsm_result cohsm_open(const void *data, size_t bytes, const cohsm_system *system,
                                  cohsm_maps **out)
{
    cohsm__wish wish;
    cohsm__logger log = cohsm__logger_of(system, "cohsm_open");

    wish.layout = COHSM_LAYOUT_COMPACT;
    wish.bytes = 0;
    wish.system = system;
    return cohsm__open_wished(data, bytes, &wish, &log, out);
}

COHSM_DEF cohsm_result cohsm_open_as(const void *data, size_t bytes, cohsm_layout layout, size_t layout_bytes,
                                     const cohsm_system *system, cohsm_maps **out)
{
    cohsm__wish wish;
    cohsm__logger log = cohsm__logger_of(system, "cohsm_open_as");

    if ((unsigned)layout >= COHSM_LAYOUT_COUNT)
        return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "layout", "is no COHSM_LAYOUT_...");
    wish.layout = layout;
    wish.bytes = layout_bytes;
    wish.system = system;
    return cohsm__open_wished(data, bytes, &wish, &log, out);
}

/* ==== src/csm/in_place.h ==== */

/* ---- files in place: no copy, and budgets ---- */

/* Reads and checks the header of a plain or packed file, and compares the file's size; nothing else is read.
   *longest receives how many segments the longest list of a packed file has, or 0 where the block is there
   as it is; *at where the block's header begins. What is wrong with a packed file's sizes is found here too,
   so that no room is made for what cannot be opened. */
static cohsm_result cohsm__file_header(const uint8_t *file, size_t bytes, cohsm__header *h, uint32_t *longest,
                                       size_t *at)
{
    *at = 0;
    *longest = 0;
    if (bytes < 16) return COHSM_ERR_FORMAT;
    if (cohsm__get_u32(file) == COHSM__PACK_MAGIC) {
#ifdef COHSM_WITHOUT_PACK
        return COHSM_ERR_MISMATCH;
#else
        if (cohsm__get_u32(file + 4) != COHSM__PACK_FORMAT) return COHSM_ERR_VERSION;
        if (cohsm__get_u32(file + 8) != bytes || bytes < COHSM__PACK_HEADER + sizeof *h)
            return COHSM_ERR_FORMAT;
        *longest = cohsm__get_u32(file + 12);
        *at = COHSM__PACK_HEADER;
#endif
    }
    if (cohsm__get_u32(file + *at) != COHSM__MAGIC) return COHSM_ERR_FORMAT;
    if (cohsm__get_u32(file + *at + 4) != COHSM__FORMAT) return COHSM_ERR_VERSION;
    if (bytes - *at < sizeof *h) return COHSM_ERR_FORMAT;
    memcpy(h, file + *at, sizeof *h);
    cohsm__host_words((uint32_t *)(void *)h, COHSM__HEADER_WORDS);
    if (!cohsm__header_sound(h)) return COHSM_ERR_FORMAT;
    if (*longest == 0 && bytes - *at != 4 * (size_t)h->words) return COHSM_ERR_FORMAT;
#ifndef COHSM_WITHOUT_PACK
    if (*longest && !cohsm__packed_sound(h, *longest, bytes)) return COHSM_ERR_FORMAT;
#endif
    return COHSM_OK;
}

/* Returns the bytes of memory that a file with this header asks for at once, trays aside. */
static uint64_t cohsm__file_cost(const cohsm__header *h, uint32_t longest, int in_place)
{
    uint64_t cost = sizeof(cohsm_maps);
    if (h->domain == COHSM_DOMAIN_LATLONG) cost += 8 * ((uint64_t)h->side[0] + h->side[1]);
    if (!in_place) cost += 4 * (uint64_t)h->words + 64u;
#ifndef COHSM_WITHOUT_PACK
    if (longest) cost += cohsm__pack_work(h, longest) + sizeof(cohsm__odds);
#else
    (void)longest;
#endif
    return cost;
}

/* Logs what is wrong with a file, or that memory was short. Returns the result. */
static cohsm_result cohsm__log_file(const cohsm__logger *log, cohsm_result result)
{
    if (result == COHSM_ERR_FORMAT) cohsm__log_text(log, "data", "is no file of csm.h, or a damaged one");
    if (result == COHSM_ERR_VERSION) cohsm__log_text(log, "data", "is a file of an unknown version");
    if (result == COHSM_ERR_MISMATCH)
        cohsm__log_text(log, "data", "is a packed file, and this csm.h was joined without pack");
    if (result == COHSM_ERR_MEMORY) cohsm__log_text(log, "data", "is not at a multiple of 64 bytes");
    return cohsm__log_result(log, result);
}

/* Makes maps of a plain file whose header is sound where it lies. */
static cohsm_result cohsm__open_in_place(const uint8_t *data, const cohsm__header *h,
                                         const cohsm__allocator *a, const cohsm__part *part, cohsm_maps **out)
{
    cohsm__memory block;
    block.memory = NULL;                /* what tells cohsm_free that there is nothing to give back */
    block.words = (uint32_t *)(uintptr_t)data;      /* the words of maps are const: nobody writes to them */
    if (cohsm__block_crc(block.words, h->words) != h->crc) return COHSM_ERR_FORMAT;
    return cohsm__open_block(a, *part, block, out);
}

/* Gives maps the layout of the desc within its budget, of which the maps take `cost`, and hands them out; if
   this fails, frees them. Trays that do not fit are none, or refused where they were asked for. */
static cohsm_result cohsm__lay_out_within(cohsm_maps *maps, const cohsm_open_desc *d, uint64_t cost,
                                          cohsm__part part, cohsm_maps **out)
{
    const size_t block = 4 * (size_t)maps->head.words;
    cohsm__wish wish;
    cohsm_result result;

    wish.layout = d->layout;
    wish.bytes = d->layout_bytes;
    wish.system = &d->system;
    if (d->budget_bytes && d->layout != COHSM_LAYOUT_COMPACT) {
        const size_t room = d->budget_bytes - (size_t)cost;
        const size_t most = room > SIZE_MAX - block ? SIZE_MAX : block + room;
        if (d->layout != COHSM_LAYOUT_BUDGET || wish.bytes > most) wish.bytes = most;
        wish.layout = COHSM_LAYOUT_BUDGET;
    }
    result = cohsm__lay_out_opened(maps, &wish, part, &maps);
    if (result != COHSM_OK) return result;
#ifndef COHSM_WITHOUT_FAST
    if (d->budget_bytes && d->layout == COHSM_LAYOUT_FAST && !maps->trays.lines) {
        cohsm_free(maps);
        return COHSM_ERR_LIMIT;
    }
#endif
    *out = maps;
    return COHSM_OK;
}

/* A file that is being opened: what its header said, and where it may lie. */
typedef struct cohsm__opening {
    const uint8_t *data;
    size_t         bytes;
    cohsm__header  head;
    uint32_t       longest;
    int            in_place;            /* the wish; then whether the file is read where it lies */
    uint64_t       cost;                /* cohsm__file_cost */
} cohsm__opening;

/* Reads the header of o->data, of o->bytes, and finds how the file will be opened. */
static cohsm_result cohsm__opening_start(cohsm__opening *o)
{
    size_t at;
    cohsm_result result = cohsm__file_header(o->data, o->bytes, &o->head, &o->longest, &at);
    if (result != COHSM_OK) return result;
    o->in_place = o->in_place && at == 0 && cohsm__host_is_little_endian();
    o->cost = cohsm__file_cost(&o->head, o->longest, o->in_place);
    return o->in_place && (uintptr_t)o->data % 64u ? COHSM_ERR_MEMORY : COHSM_OK;
}

static cohsm_result cohsm__opening_end(const cohsm__opening *o, const cohsm__allocator *a,
                                       const cohsm__part *part, cohsm_maps **out)
{
    if (o->in_place) return cohsm__open_in_place(o->data, &o->head, a, part, out);
    return cohsm__open_file(o->data, o->bytes, a, part, out);
}

static cohsm_result cohsm__open_within(const cohsm_open_desc *d, const void *data, size_t bytes,
                                       const cohsm__logger *log, cohsm_maps **out)
{
    cohsm__opening o;
    cohsm__allocator a;
    cohsm__part part, opening;
    cohsm_maps *maps = NULL;
    cohsm_result result;

    if (!cohsm__services_of(&d->system, log, &a, &part)) return COHSM_ERR_DESC;
    o.data = (const uint8_t *)data;
    o.bytes = bytes;
    o.in_place = d->in_place;
    result = cohsm__opening_start(&o);
    if (result == COHSM_OK && d->budget_bytes && o.cost > d->budget_bytes) {
        cohsm__log_bound(log, "desc.budget_bytes", d->budget_bytes, "at least", o.cost,
                         "what the file takes");
        return COHSM_ERR_LIMIT;
    }
    opening = cohsm__part_of(&part, 0.0f, d->layout == COHSM_LAYOUT_COMPACT ? 1.0f : 0.5f);
    if (result == COHSM_OK) result = cohsm__opening_end(&o, &a, &opening, &maps);
    if (result != COHSM_OK) return cohsm__log_file(log, result);
    result = cohsm__lay_out_within(maps, d, o.cost, cohsm__part_of(&part, 0.5f, 1.0f), out);
    if (result == COHSM_ERR_LIMIT) cohsm__log_text(log, "desc.layout", "asks for more trays than may be");
    return cohsm__log_result(log, result);
}

COHSM_DEF cohsm_result cohsm_open_file(const cohsm_open_desc *desc, const void *data, size_t bytes,
                                       cohsm_maps **out)
{
    cohsm_open_desc none;
    cohsm__logger log = cohsm__logger_of(desc ? &desc->system : NULL, "cohsm_open_file");

    memset(&none, 0, sizeof none);
    if (!desc) desc = &none;
    if (!data) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "data", "is NULL");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if ((unsigned)desc->layout >= COHSM_LAYOUT_COUNT)
        return cohsm__refuse_value(&log, "desc.layout", (double)desc->layout, "a COHSM_LAYOUT_...");
    return cohsm__open_within(desc, data, bytes, &log, out);
}

/* Makes of zeroed maps ones without a block, which know no more than a header says: enough for facts, for
   checks of queries, and for the sphere outside which they shadow nothing. */
static void cohsm__maps_of_header(cohsm_maps *m, const cohsm__header *h)
{
    m->head = *h;
    m->range = h->pixel_end - h->pixel_begin;
    m->simd = cohsm__simd();
    cohsm__dop_in_radii(m);
}

COHSM_DEF cohsm_result cohsm_file_info(const void *data, size_t bytes, const cohsm_system *system,
                                       cohsm_info *out)
{
    cohsm__logger log = cohsm__logger_of(system, "cohsm_file_info");
    cohsm__header h;
    cohsm_maps maps;
    uint32_t longest;
    size_t at;
    cohsm_result result;

    if (!data) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "data", "is NULL");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    result = cohsm__file_header((const uint8_t *)data, bytes, &h, &longest, &at);
    if (result != COHSM_OK) return cohsm__log_file(&log, result);
    memset(&maps, 0, sizeof maps);
    cohsm__maps_of_header(&maps, &h);
    maps.memory = &maps;                        /* a copy, as cohsm_open makes it */
    cohsm_get_info(&maps, out);
    return COHSM_OK;
}

/* ==== src/csm/stream.h ==== */

/* ---- stream: objects that come and go ---- */

typedef struct cohsm__object {
    cohsm__header head;                 /* of its file, as it was opened last */
    int           known;                /* head is filled in */
    cohsm_maps   *maps;                 /* NULL: the object is not in memory */
    const void   *data;                 /* what load_fn gave, if the maps read it in place */
    size_t        data_bytes, bytes;    /* of data; what the object takes of the budget */
    uint32_t      holds;
    uint32_t      older, newer;         /* neighbours in the ring of those in memory that nobody holds */
} cohsm__object;

struct cohsm_stream {
    cohsm_stream_desc desc;
    cohsm__allocator  allocator;
    cohsm__object    *objects;          /* one more than there are: there the ring begins and ends. Its
                                           `newer` is the object that was used least recently */
    cohsm_stream_stats info;
    size_t            unheld;           /* bytes that the objects of the ring take of info.bytes */
    cohsm_maps        shell;            /* maps without a block, of the object that is looked at */
};

static void cohsm__ring_leave(cohsm_stream *s, uint32_t i)
{
    const cohsm__object *o = &s->objects[i];
    s->objects[o->older].newer = o->newer;
    s->objects[o->newer].older = o->older;
    s->unheld -= o->bytes;
}

static void cohsm__ring_enter(cohsm_stream *s, uint32_t i)
{
    const uint32_t end = s->desc.object_count, last = s->objects[end].older;
    s->objects[i].older = last;
    s->objects[i].newer = end;
    s->objects[last].newer = i;
    s->objects[end].older = i;
    s->unheld += s->objects[i].bytes;
}

static void cohsm__unload(const cohsm_stream *s, uint32_t i, const void *data, size_t bytes)
{
    if (s->desc.unload_fn) s->desc.unload_fn(s->desc.user, i, data, bytes);
}

/* Takes an object that nobody holds, or all do at the end, out of memory. */
static void cohsm__object_leave(cohsm_stream *s, uint32_t i)
{
    cohsm__object *o = &s->objects[i];
    cohsm_free(o->maps);
    o->maps = NULL;
    if (o->data) cohsm__unload(s, i, o->data, o->data_bytes);
    o->data = NULL;
    s->info.bytes -= o->bytes;
    s->info.objects--;
}

/* Makes room in the budget. Returns 0 if what is held leaves too little, when nothing has left. */
static int cohsm__make_room(cohsm_stream *s, uint64_t bytes)
{
    const uint32_t end = s->desc.object_count;
    const size_t budget = s->desc.budget_bytes;

    if (bytes > budget || s->info.bytes - s->unheld > budget - (size_t)bytes) return 0;
    while (s->info.bytes > budget - (size_t)bytes) {
        const uint32_t i = s->objects[end].newer;
        cohsm__ring_leave(s, i);
        cohsm__object_leave(s, i);
        s->info.evictions++;
    }
    return 1;
}

/* Logs that the budget has no room for an object. */
static cohsm_result cohsm__log_no_room(const cohsm_stream *s, const cohsm__logger *log, uint32_t i,
                                       uint64_t bytes)
{
    cohsm__log_element(log, "objects", i, s->info.held ? "beside those that are held takes" : "takes",
                       (double)bytes, "within desc.budget_bytes");
    return COHSM_ERR_LIMIT;
}

/* Logs why the file of an object was refused. Returns the result. */
static cohsm_result cohsm__log_object(const cohsm__logger *log, uint32_t i, cohsm_result result)
{
    const char *text = "is no file of csm.h, or a damaged one";
    if (result == COHSM_ERR_ALLOC) return cohsm__log_result(log, result);
    if (result == COHSM_ERR_VERSION) text = "is a file of an unknown version";
    if (result == COHSM_ERR_MISMATCH) text = "is a packed file, and this csm.h was joined without pack";
    if (result == COHSM_ERR_MEMORY) text = "lies at no multiple of 64 bytes";
    cohsm__log_element_text(log, "objects", i, text);
    return result;
}

/* Opens a file that load_fn gave, after making room for it. */
static cohsm_result cohsm__object_open(cohsm_stream *s, uint32_t i, cohsm__opening *file,
                                       const cohsm__logger *log)
{
    cohsm__object *o = &s->objects[i];
    cohsm__part part;
    cohsm_info info;
    uint64_t bytes;
    cohsm_result result = file->data ? cohsm__opening_start(file) : COHSM_ERR_FORMAT;

    if (result != COHSM_OK) return cohsm__log_object(log, i, result);
    if (o->known && memcmp(&o->head, &file->head, sizeof o->head) != 0) {
        cohsm__log_element_text(log, "objects", i, "has another file than before");
        return COHSM_ERR_INPUT;
    }
    bytes = file->cost + (file->in_place ? file->bytes : 0u);
    if (!cohsm__make_room(s, bytes)) return cohsm__log_no_room(s, log, i, bytes);
    if (s->info.peak_bytes < s->info.bytes + (size_t)bytes)
        s->info.peak_bytes = s->info.bytes + (size_t)bytes;
    memset(&part, 0, sizeof part);
    result = cohsm__opening_end(file, &s->allocator, &part, &o->maps);
    if (result != COHSM_OK) return cohsm__log_object(log, i, result);
    o->maps->log = s->desc.system.log;
    o->maps->log_user = s->desc.system.user;
    o->head = o->maps->head;
    o->known = 1;
    cohsm_get_info(o->maps, &info);
    o->bytes = info.memory_bytes + (file->in_place ? file->bytes : 0u);
    s->info.bytes += o->bytes;
    s->info.objects++;
    return COHSM_OK;
}

static cohsm_result cohsm__object_load(cohsm_stream *s, uint32_t i, const cohsm__logger *log)
{
    cohsm__object *o = &s->objects[i];
    const void *data = NULL;
    cohsm__opening file;
    cohsm_result result;

    file.bytes = 0;
    if (s->desc.load_fn(s->desc.user, i, &data, &file.bytes) != 0) {
        cohsm__log_element_text(log, "objects", i, "has no file: desc.load_fn said so");
        return COHSM_ERR_CANCELLED;
    }
    file.data = (const uint8_t *)data;
    file.in_place = s->desc.in_place;
    result = cohsm__object_open(s, i, &file, log);
    if (result == COHSM_OK && file.in_place) {
        o->data = data;
        o->data_bytes = file.bytes;
    } else cohsm__unload(s, i, data, file.bytes);
    return result;
}

static cohsm_result cohsm__object_hold(cohsm_stream *s, uint32_t i, const cohsm__logger *log)
{
    cohsm__object *o = &s->objects[i];
    cohsm_result result;

    if (o->maps) {
        s->info.hits++;
        if (!o->holds) cohsm__ring_leave(s, i);
    } else {
        result = cohsm__object_load(s, i, log);
        if (result != COHSM_OK) return result;
        s->info.loads++;
    }
    if (!o->holds++) s->info.held++;
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_stream_use(cohsm_stream *s, uint32_t object, const cohsm_maps **out)
{
    cohsm__logger log = cohsm__logger_of(s ? &s->desc.system : NULL, "cohsm_stream_use");
    cohsm_result result;

    if (!s) return COHSM_ERR_ARGUMENT;
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (object >= s->desc.object_count) {
        cohsm__log_bound(&log, "object", object, "below", s->desc.object_count, "the number of objects");
        return COHSM_ERR_ARGUMENT;
    }
    result = cohsm__object_hold(s, object, &log);
    if (result == COHSM_OK) *out = s->objects[object].maps;
    return result;
}

COHSM_DEF void cohsm_stream_end(cohsm_stream *s, uint32_t object)
{
    if (!s || object >= s->desc.object_count || !s->objects[object].holds) return;
    if (--s->objects[object].holds) return;
    s->info.held--;
    cohsm__ring_enter(s, object);
}

COHSM_DEF void cohsm_stream_get_stats(const cohsm_stream *s, cohsm_stream_stats *out)
{
    if (s && out) *out = s->info;
}

COHSM_DEF cohsm_result cohsm_stream_create(const cohsm_stream_desc *desc, cohsm_stream **out)
{
    cohsm__logger log = cohsm__logger_of(desc ? &desc->system : NULL, "cohsm_stream_create");
    cohsm__allocator a;
    cohsm__part part;
    cohsm_stream *s;
    uint32_t i;

    if (!desc) return COHSM_ERR_ARGUMENT;
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (!cohsm__services_of(&desc->system, &log, &a, &part)) return COHSM_ERR_DESC;
    if (!desc->object_count || desc->object_count > 1u << 24)
        return cohsm__refuse_value(&log, "desc.object_count", (double)desc->object_count, "1..2^24");
    if (!desc->budget_bytes) return cohsm__refuse_value(&log, "desc.budget_bytes", 0.0, "above 0");
    if (!desc->load_fn) return cohsm__refuse(&log, COHSM_ERR_DESC, "desc.load_fn", "is NULL");
    s = (cohsm_stream *)cohsm__alloc(&a, sizeof *s);
    if (!s) return cohsm__log_result(&log, COHSM_ERR_ALLOC);
    memset(s, 0, sizeof *s);
    s->desc = *desc;
    s->allocator = a;
    s->shell.log = desc->system.log;
    s->shell.log_user = desc->system.user;
    s->objects = (cohsm__object *)cohsm__alloc_array(&a, (size_t)desc->object_count + 1u, sizeof *s->objects);
    if (!s->objects) {
        cohsm__free(&a, s);
        return cohsm__log_result(&log, COHSM_ERR_ALLOC);
    }
    memset(s->objects, 0, ((size_t)desc->object_count + 1u) * sizeof *s->objects);
    i = desc->object_count;
    s->objects[i].older = s->objects[i].newer = i;
    *out = s;
    return COHSM_OK;
}

COHSM_DEF void cohsm_stream_free(cohsm_stream *s)
{
    cohsm__allocator a;
    uint32_t i;

    if (!s) return;
    a = s->allocator;
    for (i = 0; i < s->desc.object_count; i++)
        if (s->objects[i].maps) cohsm__object_leave(s, i);
    cohsm__free(&a, s->objects);
    cohsm__free(&a, s);
}

/* ==== src/csm/stream_scene.h ==== */

/* ---- stream: scenes ---- */

/* What cohsm_stream_visible_scene asks, object by object; its answers lie apart until all are there. */
typedef struct cohsm__scene_walk {
    cohsm_stream *stream;
    const cohsm_stream_instance *instances;
    uint32_t    count;
    cohsm_query query;
    float      *visible;
    cohsm__tile tile;
    const cohsm__logger *log;
} cohsm__scene_walk;

/* Returns instance number i with maps that know what the header of its object says, and no more. */
static cohsm_instance cohsm__instance_of_header(const cohsm__scene_walk *w, uint32_t i)
{
    cohsm_stream *s = w->stream;
    cohsm_instance instance;
    cohsm__maps_of_header(&s->shell, &s->objects[w->instances[i].object].head);
    instance.maps = &s->shell;
    memcpy(instance.transform, w->instances[i].transform, sizeof instance.transform);
    return instance;
}

/* Checks instances and query. Objects that were never loaded are loaded for it. */
static cohsm_result cohsm__check_walk(const cohsm__scene_walk *w)
{
    const cohsm_stream *s = w->stream;
    uint32_t i, object;

    for (i = 0; i < w->count; i++) {
        cohsm_instance instance;
        cohsm_result result = COHSM_OK;
        object = w->instances[i].object;
        if (object >= s->desc.object_count) {
            cohsm__log_element(w->log, "instances", i, "has the object", (double)object,
                               "below desc.object_count");
            return COHSM_ERR_INPUT;
        }
        if (!s->objects[object].known) {
            result = cohsm__object_hold(w->stream, object, w->log);
            if (result != COHSM_OK) return result;
            cohsm_stream_end(w->stream, object);
        }
        instance = cohsm__instance_of_header(w, i);
        result = cohsm__check_instance(&instance, i, &w->query, w->log);
        if (result != COHSM_OK) return result;
    }
    return COHSM_OK;
}

/* Finds the samples of a block that ask an instance. Returns 0 if none of them sees any light still. */
static int cohsm__find_asking(const cohsm__scene_walk *w, cohsm__bunch *b, const cohsm_instance *instance,
                              uint32_t i, size_t begin, size_t count, int own)
{
    const cohsm_light_kind kind = w->query.light_kind;
    const int tested = kind == COHSM_LIGHT_DIRECTION || kind == COHSM_LIGHT_POSITION;
    size_t word;
    uint32_t bits;

    b->count = 1;
    cohsm__find_asked(b, instance, i, &w->query, begin, count, own, tested);
    for (word = 0; word < (count + 31) / 32; word++)
        for (bits = b->asked[0][word]; bits; bits &= bits - 1u)
            if (w->visible[begin + 32 * word + cohsm__first_bit_plain(bits)] > 0.0f) return 1;
    return 0;
}

/* Asks one instance for all samples from `begin` on that may have to. */
static void cohsm__ask_object(cohsm__scene_walk *w, const cohsm_instance *instance, uint32_t i, size_t begin,
                              int own)
{
    cohsm__bunch b;
    cohsm__asking a;

    a.instance = instance;
    a.number = i;
    a.asked = b.asked[0];
    for (; begin < w->query.count; begin += a.count) {
        a.begin = begin;
        a.count = w->query.count - begin < COHSM__BLOCK ? w->query.count - begin : (size_t)COHSM__BLOCK;
        if (cohsm__find_asking(w, &b, instance, i, begin, a.count, own))
            cohsm__ask_instance(&w->tile, &w->query, &a, w->visible);
    }
}

/* Holds the object of an instance and asks it, if any sample has to. */
static cohsm_result cohsm__visit(cohsm__scene_walk *w, uint32_t i, int own)
{
    cohsm_instance instance = cohsm__instance_of_header(w, i);
    const uint32_t object = w->instances[i].object;
    cohsm__bunch b;
    size_t begin, n;
    cohsm_result result;

    for (begin = 0; begin < w->query.count; begin += n) {
        n = w->query.count - begin < COHSM__BLOCK ? w->query.count - begin : (size_t)COHSM__BLOCK;
        if (cohsm__find_asking(w, &b, &instance, i, begin, n, own)) break;
    }
    if (begin >= w->query.count) return COHSM_OK;
    result = cohsm__object_hold(w->stream, object, w->log);
    if (result != COHSM_OK) return result;
    instance.maps = w->stream->objects[object].maps;
    cohsm__ask_object(w, &instance, i, begin, own);
    cohsm_stream_end(w->stream, object);
    return COHSM_OK;
}

/* Asks all instances: first the one that each sample lies on, then the others in their order. */
static cohsm_result cohsm__walk_scene(cohsm__scene_walk *w)
{
    uint32_t i;
    size_t k;
    int own;
    cohsm_result result;

    for (k = 0; k < w->query.count; k++) w->visible[k] = 1.0f;
    for (own = w->query.entities != NULL; own >= 0; own--)
        for (i = 0; i < w->count; i++) {
            result = cohsm__visit(w, i, own);
            if (result != COHSM_OK) return result;
        }
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_stream_visible_scene(cohsm_stream *s, const cohsm_stream_instance *instances,
                                                  size_t instance_count, const cohsm_query *query,
                                                  float *visible, size_t *refused)
{
    cohsm__logger log = cohsm__logger_of(s ? &s->desc.system : NULL, "cohsm_stream_visible_scene");
    cohsm__scene_walk w;
    cohsm_result result;

    if (!s) return COHSM_ERR_ARGUMENT;
    if (!query) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "query", "is NULL");
    if (query->count && !visible) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "visible", "is NULL");
    if (instance_count && !instances) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "instances", "is NULL");
    if (instance_count >= UINT32_MAX) {
        cohsm__log_value(&log, "instance_count", (double)instance_count, "below 2^32 - 1");
        return COHSM_ERR_LIMIT;
    }
    w.stream = s;
    w.instances = instances;
    w.count = (uint32_t)instance_count;
    w.query = cohsm__complete_query(query);
    w.log = &log;
    if (w.count <= 1) w.query.entities = NULL;              /* entities decide the order alone */
    result = cohsm__check_walk(&w);
    if (result != COHSM_OK) return result;
    if (query->count) {
        w.visible = (float *)cohsm__alloc_array(&s->allocator, query->count, sizeof(float));
        if (!w.visible) return cohsm__log_result(&log, COHSM_ERR_ALLOC);
        result = cohsm__walk_scene(&w);
        if (result == COHSM_OK) memcpy(visible, w.visible, query->count * sizeof(float));
        cohsm__free(&s->allocator, w.visible);
        if (result != COHSM_OK) return result;
    }
    if (refused) *refused = cohsm__count_refused(visible, query->count);
    return COHSM_OK;
}

/* ==== src/csm/places.h ==== */

/* ---- places: few maps that stand for many ---- */

enum { COHSM__MOST_CANDIDATES = 16384, COHSM__MOST_EXCHANGES = 8 };

typedef struct cohsm__placing {
    uint32_t  count, place_count;       /* candidates, places */
    size_t    words;                    /* of bits for each candidate */
    uint32_t *bits;                     /* whether each receiver is lit from there */
    uint32_t *apart;                    /* count x count: receivers whose answers differ */
    uint32_t *best, *second;            /* of each candidate: the least of its `apart` to a place, the next */
    uint32_t *of;                       /* which candidate is the place that has the least */
    uint8_t  *chosen;
} cohsm__placing;

static void cohsm__placing_free(const cohsm__placing *c, const cohsm__allocator *a)
{
    cohsm__free(a, c->bits);
    cohsm__free(a, c->apart);
    cohsm__free(a, c->best);
    cohsm__free(a, c->second);
    cohsm__free(a, c->of);
    cohsm__free(a, c->chosen);
}

static int cohsm__placing_make(cohsm__placing *c, const cohsm__allocator *a, uint32_t count, size_t receivers)
{
    size_t pairs, all;
    memset(c, 0, sizeof *c);
    c->count = count;
    c->words = (receivers + 31u) / 32u;
    if (!cohsm__mul_size(count, count, &pairs) || !cohsm__mul_size(count, c->words, &all)) return 0;
    c->bits = (uint32_t *)cohsm__alloc_array(a, all, 4);
    c->apart = (uint32_t *)cohsm__alloc_array(a, pairs, 4);
    c->best = (uint32_t *)cohsm__alloc_array(a, count, 4);
    c->second = (uint32_t *)cohsm__alloc_array(a, count, 4);
    c->of = (uint32_t *)cohsm__alloc_array(a, count, 4);
    c->chosen = (uint8_t *)cohsm__alloc_array(a, count, 1);
    if (!c->bits || !c->apart || !c->best || !c->second || !c->of || !c->chosen) return 0;
    memset(c->bits, 0, 4 * all);
    memset(c->chosen, 0, count);
    return 1;
}

/* Asks each candidate's map for all receivers. */
static cohsm_result cohsm__placing_ask(const cohsm__placing *c, const cohsm_places_desc *d, float *visible,
                                      const cohsm__part *part)
{
    cohsm_query q;
    uint32_t i;
    size_t k;
    cohsm_result result = COHSM_OK;

    memset(&q, 0, sizeof q);
    q.count = d->receiver_count;
    q.positions = d->receivers;
    q.position_stride = d->receiver_stride;
    q.one_light = 1;
    q.light_kind = COHSM_LIGHT_INDEX;
    q.bias = d->bias;
    for (i = 0; i < c->count && result == COHSM_OK; i++) {
        if (cohsm__cancelled(part, i, c->count, 1)) return COHSM_ERR_CANCELLED;
        q.lights = &i;
        result = cohsm_visible(d->candidates, &q, visible, NULL);
        for (k = 0; k < q.count && result == COHSM_OK; k++)
            if (visible[k] > 0.5f) c->bits[c->words * i + k / 32] |= 1u << k % 32;
    }
    return result;
}

/* Counts for each pair of candidates the receivers whose answers differ. */
static cohsm_result cohsm__placing_compare(const cohsm__placing *c, const cohsm__part *part)
{
    uint32_t i, j, n;
    size_t w;

    for (i = 0; i < c->count; i++) {
        const uint32_t *a = c->bits + c->words * i;
        if (cohsm__cancelled(part, i, c->count, 1)) return COHSM_ERR_CANCELLED;
        for (j = 0; j <= i; j++) {
            const uint32_t *b = c->bits + c->words * j;
            for (w = 0, n = 0; w < c->words; w++) n += cohsm__popcount(a[w] ^ b[w]);
            c->apart[(size_t)i * c->count + j] = c->apart[(size_t)j * c->count + i] = n;
        }
    }
    return COHSM_OK;
}

/* Finds for each candidate the place that stands for it, and the second best. Returns the sum of errors. */
static uint64_t cohsm__placing_assign(const cohsm__placing *c)
{
    uint64_t sum = 0;
    uint32_t i, j;

    for (i = 0; i < c->count; i++) {
        c->best[i] = c->second[i] = UINT32_MAX;
        for (j = 0; j < c->count; j++) {
            const uint32_t n = c->apart[(size_t)i * c->count + j];
            if (!c->chosen[j]) continue;
            if (n < c->best[i]) {
                c->second[i] = c->best[i];
                c->best[i] = n;
                c->of[i] = j;
            } else if (n < c->second[i]) c->second[i] = n;
        }
        sum += c->best[i];
    }
    return sum;
}

/* Returns the candidate that would lower the sum of errors most as one more place, and writes by how much.
   Errors are those of best[], or, of candidates whose place is `without`, of second[]. */
static uint32_t cohsm__placing_next(const cohsm__placing *c, uint32_t without, int64_t *gain)
{
    uint32_t i, j, found = 0;

    *gain = -1;
    for (j = 0; j < c->count; j++) {
        const uint32_t *row = c->apart + (size_t)j * c->count;
        int64_t sum = 0;
        if (c->chosen[j]) continue;
        for (i = 0; i < c->count; i++) {
            const uint32_t now = c->of[i] == without ? c->second[i] : c->best[i];
            if (row[i] < now) sum += (int64_t)now - row[i];
        }
        if (sum <= *gain) continue;
        *gain = sum;
        found = j;
    }
    return found;
}

/* Chooses one place after the other. */
static cohsm_result cohsm__placing_grow(cohsm__placing *c, uint32_t wanted, const cohsm__part *part)
{
    uint32_t i, next;
    int64_t gain;

    for (i = 0; i < c->count; i++) {
        c->best[i] = (uint32_t)(32 * c->words) + 1u;    /* worse than any place */
        c->of[i] = UINT32_MAX;
    }
    for (c->place_count = 0; c->place_count < wanted; c->place_count++) {
        if (cohsm__cancelled(part, c->place_count, wanted, 1)) return COHSM_ERR_CANCELLED;
        next = cohsm__placing_next(c, UINT32_MAX - 1u, &gain);
        c->chosen[next] = 1;
        for (i = 0; i < c->count; i++) {
            const uint32_t n = c->apart[(size_t)next * c->count + i];
            if (n >= c->best[i]) continue;
            c->best[i] = n;
            c->of[i] = next;
        }
    }
    return COHSM_OK;
}

/* Exchanges each place for the candidate that lowers the errors most, once through all places. *changed
   receives 0 if there was no exchange that lowered them. */
static cohsm_result cohsm__placing_exchange(const cohsm__placing *c, const cohsm__part *part, int *changed)
{
    uint64_t lost;
    uint32_t j, i, next;
    int64_t gain;

    *changed = 0;
    (void)cohsm__placing_assign(c);
    for (j = 0; j < c->count && c->place_count > 1; j++) {
        if (!c->chosen[j]) continue;
        if (cohsm__cancelled(part, j, c->count, 1)) return COHSM_ERR_CANCELLED;
        for (i = 0, lost = 0; i < c->count; i++) lost += c->of[i] == j ? c->second[i] - c->best[i] : 0u;
        next = cohsm__placing_next(c, j, &gain);
        if (gain <= (int64_t)lost) continue;
        c->chosen[j] = 0;
        c->chosen[next] = 1;
        (void)cohsm__placing_assign(c);
        *changed = 1;
    }
    return COHSM_OK;
}

static cohsm_result cohsm__place_all(cohsm__placing *c, const cohsm_places_desc *d, float *visible,
                                     const cohsm__part *part)
{
    cohsm__part step = cohsm__part_of(part, 0.0f, 0.4f);
    cohsm_result result = cohsm__placing_ask(c, d, visible, &step);
    int i, changed = 1;

    step = cohsm__part_of(part, 0.4f, 0.7f);
    if (result == COHSM_OK) result = cohsm__placing_compare(c, &step);
    step = cohsm__part_of(part, 0.7f, 0.8f);
    if (result == COHSM_OK) result = cohsm__placing_grow(c, d->place_count, &step);
    for (i = 0; i < COHSM__MOST_EXCHANGES && changed && result == COHSM_OK; i++) {
        step = cohsm__part_of(part, 0.8f + 0.2f * (float)i / (float)COHSM__MOST_EXCHANGES,
                              0.8f + 0.2f * (float)(i + 1) / (float)COHSM__MOST_EXCHANGES);
        result = cohsm__placing_exchange(c, &step, &changed);
    }
    return result;
}

/* Checks what is asked for. */
static cohsm_result cohsm__check_places(const cohsm_places_desc *d, const cohsm__logger *log)
{
    uint32_t count;
    if (!d->candidates) return cohsm__refuse(log, COHSM_ERR_DESC, "desc.candidates", "is NULL");
    if (!d->receivers) return cohsm__refuse(log, COHSM_ERR_DESC, "desc.receivers", "is NULL");
    count = d->candidates->head.map_count;
    if (count > COHSM__MOST_CANDIDATES)
        return cohsm__refuse_value(log, "the number of candidates", (double)count, "at most 16,384");
    if (!d->receiver_count || d->receiver_count > 1u << 28)
        return cohsm__refuse_value(log, "desc.receiver_count", (double)d->receiver_count, "1..2^28");
    if (!cohsm__stride_valid(d->receiver_stride, 12))
        return cohsm__refuse_value(log, "desc.receiver_stride", (double)d->receiver_stride,
                                   "0, or a multiple of 4 from 12 on");
    if (!cohsm__finite(d->bias)) return cohsm__refuse_value(log, "desc.bias", (double)d->bias, "finite");
    if (!d->place_count || d->place_count > count)
        return cohsm__refuse_value(log, "desc.place_count", (double)d->place_count,
                                   "1 or more, and at most the number of candidates");
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_places_choose(const cohsm_places_desc *desc, uint32_t *places, uint32_t *instead,
                                           double *error)
{
    cohsm__logger log = cohsm__logger_of(desc ? &desc->system : NULL, "cohsm_places_choose");
    cohsm__allocator a;
    cohsm__part part;
    cohsm__placing c;
    float *visible;
    uint32_t i, n;
    cohsm_result result;

    if (!desc) return COHSM_ERR_ARGUMENT;
    if (!places) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "places", "is NULL");
    if (!instead) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "instead", "is NULL");
    if (!cohsm__services_of(&desc->system, &log, &a, &part)) return COHSM_ERR_DESC;
    result = cohsm__check_places(desc, &log);
    if (result != COHSM_OK) return result;
    visible = (float *)cohsm__alloc_array(&a, desc->receiver_count, sizeof *visible);
    if (!cohsm__placing_make(&c, &a, desc->candidates->head.map_count, desc->receiver_count) || !visible)
        result = COHSM_ERR_ALLOC;
    if (result == COHSM_OK) result = cohsm__place_all(&c, desc, visible, &part);
    if (result == COHSM_OK) {
        const double sum = (double)cohsm__placing_assign(&c);
        if (error) *error = sum / ((double)c.count * (double)desc->receiver_count);
        for (i = 0, n = 0; i < c.count; i++) {          /* best: the number of a candidate among the places */
            c.best[i] = n;
            if (c.chosen[i]) places[n++] = i;
        }
        for (i = 0; i < c.count; i++) instead[i] = c.best[c.of[i]];
    }
    cohsm__placing_free(&c, &a);
    cohsm__free(&a, visible);
    return cohsm__log_result(&log, result);
}

/* ==== src/shared/fp_end.h ==== */

/* unit fp_end: the user's options again. clang and MSVC keep contraction off to the end of the file. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__)
#pragma GCC pop_options
#endif

/* ==== src/csm/end.h ==== */

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
