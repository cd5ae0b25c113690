/* envshadow.h - v1.0.0 - environment-map shadows: a sky as shadow-casting lights, for any motion - MIT-0 OR Unlicense

   What it does

   Turns a radiance map of the surroundings into k directional lights, by importance, so that their energy is the map's
   energy; lays out, fits and (on the CPU) renders one shadow map for each; and shades arrays of points with all of them
   in one pass. After Knuth and Fuhrmann, "Self-Shadowing of Dynamic Scenes with Environment Maps using the GPU",
   WSCG 2005; the lights after Agarwal et al. (2003), Debevec (2005), Viriyothai and Debevec (2009). Nothing is computed
   on the geometry beforehand: it may deform, tear, be open or intersect itself.

   What it does not do

   - Lights are at infinity: no light enters from inside the scene, and all of it sees the same map.
   - k shadow maps see k directions. Too few lights show as separate shadow edges; too small maps as jagged ones, and
     walls thinner than the filter's radius and four texels may leak. docs/envshadow.md has pictures and figures.
   - No bounced light, no rendering of pictures, no file access, no threads of its own.

   Quick start

   In exactly one source file write the define; everywhere else include the header alone.

       #define ENVSHADOW_IMPLEMENTATION
       #include "envshadow.h"
       #include <stdio.h>

       static const float corners[] = { -1, 1, -1,  1, 1, -1,  1, 1, 1,  -1, 1, 1 };    // a square above the floor
       static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2 };

       int main(void)
       {
           static float sky[3 * 64 * 32];
           const float points[] = { 0, 0, 0,  9, 0, 0 }, normals[] = { 0, 1, 0,  0, 1, 0 };
           envsh_map map = { ENVSH_MAP_LATLONG, 64, 32, sky, 0 };
           envsh_mesh mesh = { corners, 4, 0, triangles, 6 };
           envsh_query query = envsh_query_default();
           envsh_lights *lights;
           envsh_maps *maps;
           const envsh_light *list;
           uint32_t count;
           float irradiance[6];

           for (int i = 0; i < 3 * 64 * 16; i++) sky[i] = 1;                            // bright above, black below
           if (envsh_lights_build(NULL, &map, &lights, NULL) != ENVSH_OK) return 1;
           list = envsh_lights_get(lights, &count);
           if (envsh_maps_create(NULL, count, &maps) != ENVSH_OK) return 1;
           envsh_maps_begin(maps, list, count, envsh_bounds_of(&mesh, 1, NULL));        // each frame
           envsh_maps_draw(maps, &mesh, NULL);
           envsh_maps_end(maps);
           query.points = points;
           query.normals = normals;
           query.count = 2;
           envsh_shade(maps, &query, irradiance);
           printf("under the square %.2f, far from it %.2f\n", (double)irradiance[0], (double)irradiance[3]);
           envsh_maps_free(maps);
           envsh_lights_free(lights);
           return !(irradiance[0] < 2 && irradiance[3] > 3);
       }

   Conventions

   Right-handed, +Y up (in a scene with Z up turn the lights by envsh_rotate); matrices are column-major float[16];
   directions have unit length and point from the surface to the light; distances in your units, angles in radians,
   radiance in W/(sr m^2), irradiance in W/m^2.

     map        the environment: radiance of all directions, latitude-longitude or six cube faces, one float RGB a texel
     light      a directional light that stands for a stratum
     stratum    a region of the map, given to one light: radiance x solid angle is summed into it, per channel
     extent     how far the stratum's radiance spreads about the light's direction: an ellipse of two half axes
     tile       the shadow map of one light inside the atlas; four tiles share a texel's RGBA where that is asked for
     guard      texels around each tile that are never drawn into, so that filters find "nothing here" and no neighbour
     caster     what is drawn into shadow maps; receiver: a point that is shaded
     depth      0 nearest to the light .. 1 farthest caster, linear in distance; 1 or more means nothing there

   Latitude-longitude: row 0 is +Y, v = acos(y) / pi from the top, u = 0.5 + atan2(z, x) / (2 pi). Cube: faces
   +X -X +Y -Y +Z -Z one after another, each as OpenGL stores it.

   How it works

   Lights. Texels weigh radiance x solid angle, computed exactly. STRUCTURED thresholds the map into six layers, shares
   lights out among connected bright regions by importance L min(w, 0.01 sr)^(1/4) and spreads them by farthest-first
   traversal; MEDIAN_CUT halves energy along the longer side; VARIANCE cuts where the spread of directions falls most;
   CDF inverts the cumulative distribution on a grid of (i + 0.5) / n. Cuts of latitude-longitude maps begin at the
   column of least energy, so that turning the map turns the lights.

   Shadow maps. One orthographic map for each light, fitted to the casters' bounds and snapped to its texels. A receiver
   is moved along its normal by bias x texel x sine and compared with its own plane's depth at each tap, so that steep
   light needs no more bias than flat light.

   The knobs, and what each trades:

     light_count   fewer lights: shadow edges of single lights (Fig. 3 of the paper); time and memory grow with k
     map_size      fewer texels: jagged contact shadows, leaks through thin walls; memory grows with its square
     filter        PLAIN is sharp; SMOOTH and PCF blur every edge alike (the paper's); PENUMBRA by the stratum's extent
                   and the blocker's distance (its future work): the fewest lights for a picture
     radius        of PENUMBRA, texels at most: with too few, shadows of a large sun stay sharp far from their casters
     bias          too little: acne; too much: light under things that touch the ground

   Memory: light_count strata: 76 bytes a texel of the map while building (79 with split_sun), 16 kept. Atlas: 4 bytes a
   texel of map_size^2 x capacity, and a 32nd for the depth bounds of cells.

   Configuration

     ENVSHADOW_IMPLEMENTATION   in one source file: compiles the code
     ENVSHADOW_STATIC           everywhere it is included: a private copy, all functions static
     ENVSH_DEF                  everywhere: your own linkage instead

   Memory, errors, threads, determinism

   All memory comes from the allocator in the desc, called from the thread that called us. Every function that can fail
   returns an envsh_result; where it is not ENVSH_OK, outputs are untouched and nothing leaks. There are no globals;
   const objects may be read by any number of threads, one that is written belongs to one. Lights, maps and shading have
   the same bytes on every compiler, byte order and thread count (not with x87 arithmetic, nor clang's -ffast-math).

   Cost: docs/envshadow.md and build/bench envshadow_lights.   History: CHANGELOG.md.   Licence: end of this file. */
#ifndef ENVSHADOW_H
#define ENVSHADOW_H

#define ENVSH_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#include <stddef.h>
#include <stdint.h>

#ifndef ENVSH_DEF
#ifdef ENVSHADOW_STATIC
#define ENVSH_DEF static inline
#else
#define ENVSH_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- results ---- */

#define ENVSH_RESULTS(X)                                                                                     \
    X(ENVSH_OK, "ok")                                                                                        \
    X(ENVSH_ERR_ARGUMENT, "an argument is NULL, zero, not finite or out of range")                           \
    X(ENVSH_ERR_DESC, "a desc field is out of range")                                                        \
    X(ENVSH_ERR_MAP, "the map has no texels, or an unknown projection")                                      \
    X(ENVSH_ERR_MESH, "the mesh has indices or strides out of range")                                        \
    X(ENVSH_ERR_ALLOC, "the allocator returned no memory")                                                   \
    X(ENVSH_ERR_LIMIT, "a size overflows or passes a limit")                                                 \
    X(ENVSH_ERR_ORDER, "envsh_maps_begin, or envsh_maps_end before shading, must come first")                \
    X(ENVSH_ERR_CANCELLED, "cancelled by the progress callback")

typedef enum envsh_result {
#define ENVSH__ENUM(name, text) name,
    ENVSH_RESULTS(ENVSH__ENUM)
#undef ENVSH__ENUM
    ENVSH_RESULT_COUNT
} envsh_result;

ENVSH_DEF const char *envsh_result_text(envsh_result result);
/* A constant string for any value, "unknown result" beyond the list. */

/* ---- memory, threads, progress: the caller's ---- */

typedef struct envsh_allocator {    /* all zero = malloc and free; else both functions */
    void *(*alloc_fn)(size_t size, void *user);   /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} envsh_allocator;

typedef void (*envsh_task)(void *context, size_t index);
typedef void (*envsh_parallel_for)(void *user, size_t count, envsh_task task, void *context);
/* Must call task(context, i) once for each i < count, in any order and on any threads, and return when all are done. */

typedef int (*envsh_progress)(void *user, float fraction);
/* Called between steps, from the thread that called us, fraction 0..1 never falling; not 0 cancels. */

/* ---- the map ---- */

typedef enum envsh_projection {
    ENVSH_MAP_DEFAULT,              /* = ENVSH_MAP_LATLONG */
    ENVSH_MAP_LATLONG,
    ENVSH_MAP_CUBE,
    ENVSH_PROJECTION_COUNT
} envsh_projection;

typedef struct envsh_map {
    envsh_projection projection;
    uint32_t     width, height;     /* of a face: a cube's are equal. At most 2^27 texels in all */
    const float *rgb;               /* linear radiance; row 0 first, the faces of a cube one after another */
    size_t       texel_stride;      /* bytes from one texel to the next, a multiple of 4, >= 12; 0 = 12 */
} envsh_map;

ENVSH_DEF double envsh_texel_solid_angle(envsh_projection projection, uint32_t width, uint32_t height,
                                         uint32_t x, uint32_t y);
/* Steradians of texel x, y (of any face of a cube), exact: all texels add up to 4 pi. 0 outside the map. */

ENVSH_DEF void envsh_texel_direction(envsh_projection projection, uint32_t width, uint32_t height, uint32_t face,
                                     float x, float y, float direction[3]);
/* Unit direction of the point x, y in texels from the top left corner; + 0.5 is a texel's centre. face: of a cube.
   Beyond the map it goes on round the sphere, or on the face's plane, to 8 times its size; what is not finite counts
   as 0. */

/* ---- lights from the map ---- */

typedef enum envsh_method {
    ENVSH_METHOD_DEFAULT,           /* = ENVSH_METHOD_VARIANCE, the best by measurement (docs/envshadow.md) */
    ENVSH_METHOD_STRUCTURED,        /* structured importance sampling, Agarwal et al. 2003: the paper's. All methods are
                                       this one where a cube map becomes fewer than 6 lights (the sun not counted) */
    ENVSH_METHOD_MEDIAN_CUT,        /* Debevec 2005, for any k */
    ENVSH_METHOD_VARIANCE,          /* minimum variance, after Viriyothai and Debevec 2009 */
    ENVSH_METHOD_CDF,               /* stratified inversion of the distribution: the baseline */
    ENVSH_METHOD_COUNT
} envsh_method;

#define ENVSH_MAX_LIGHTS 8192u
#define ENVSH_NO_LIGHT UINT32_MAX   /* stratum of texels below the horizon of hemisphere */

typedef struct envsh_desc {
    uint32_t        light_count;    /* k, 1..ENVSH_MAX_LIGHTS; 0 = 128. Fewer come where the map has fewer lit texels,
                                       cuts fall into single texels or below the horizon: take `count` */
    envsh_method    method;
    int             hemisphere;     /* not 0: only directions with y > 0 count */
    int             split_sun;      /* not 0: a small spot that outshines a light's share becomes light 0 of its own,
                                       here or when it comes up in envsh_lights_follow; where it goes out, light 0 stays
                                       what it was until there is one again */
    envsh_allocator allocator;
} envsh_desc;                       /* zero it, then set what you care about */

#define ENVSH_LIGHT_SUN 1u          /* flags: what split_sun took out of the map */

typedef struct envsh_light {
    float    direction[3];          /* unit, to the light: mean of the stratum's directions, weighted by luminance */
    float    irradiance[3];         /* on a plane that faces it: radiance x solid angle over the stratum, W/m^2 */
    float    solid_angle;           /* of the stratum, sr */
    float    axis_u[3], axis_v[3];  /* extent: half axes of the ellipse with the spread of its radiance, at right angles
                                       to direction and each other; |axis_u| >= |axis_v|, tangents of angles,
                                       below 1e3 */
    uint32_t id;                    /* stays with a light through envsh_lights_follow and envsh_match */
    uint32_t flags;
} envsh_light;

typedef struct envsh_stats {
    uint32_t lights;                /* made */
    uint32_t changed;               /* follow: lights that were split off, and thus begin anew */
    uint64_t bad_texels;            /* with a channel that is not finite, negative or above 1e30: it counts as 0 */
    double   energy[3];             /* integral of the map over what counts, W/m^2 */
    float    largest_move;          /* follow: of a light that stayed, radians */
    float    mean_move;             /* the same, weighted by energy */
    size_t   peak_bytes;            /* asked of the allocator at once, kept memory included */
} envsh_stats;

typedef struct envsh_lights envsh_lights;   /* the lights and their strata */

ENVSH_DEF envsh_result envsh_lights_build(const envsh_desc *desc, const envsh_map *map, envsh_lights **out,
                                          envsh_stats *stats);
/* desc    NULL = all defaults
   out     written on ENVSH_OK only; a black map gives 0 lights
   stats   may be NULL
   Errors  ENVSH_ERR_ARGUMENT (NULL), ENVSH_ERR_DESC, ENVSH_ERR_MAP, ENVSH_ERR_LIMIT, ENVSH_ERR_ALLOC
   Cost    about 20 ms for 1024 x 512 texels and 300 lights; O(texels log k) */

ENVSH_DEF const envsh_light *envsh_lights_get(const envsh_lights *lights, uint32_t *count);
/* The lights, valid until the next follow or free. */

ENVSH_DEF const uint32_t *envsh_lights_strata(const envsh_lights *lights, size_t *count);
/* For each texel of the map the index of its light, or ENVSH_NO_LIGHT. */

ENVSH_DEF void envsh_lights_free(envsh_lights *lights);     /* accepts NULL */

ENVSH_DEF envsh_result envsh_lights_jitter(const envsh_lights *lights, uint32_t frame, uint32_t seed, envsh_light *out);
/* The same lights with directions inside their strata, chosen in proportion to luminance, other ones each frame (a
   low-discrepancy sequence): the mean of many frames tends to the exact picture. Energy stays exact in each. Extents
   stay as they are: at right angles to the light's own direction.
   out     as many as there are lights */

ENVSH_DEF envsh_result envsh_lights_follow(envsh_lights *lights, const envsh_map *map, uint32_t light_count,
                                           envsh_stats *stats);
/* The next frame of a video map, or another k. Strata stay, so that a light moves by what changed inside its own; where
   the video has made shares very uneven, at most an eighth of the lights, or as many as k asks for, begin anew (new id)
   by splitting the stratum that spreads most, and the two neighbours that lose least are merged. The same map and k
   give the same bytes (after METHOD_CDF from the second call on: it then takes mean directions).
   light_count  0 = as before; where the map was too black for that, as many as were asked for, as soon as another has
                the texels: all begin anew then. So give maps room for as many as you ask for
   Errors  those of the build; ENVSH_ERR_ARGUMENT for a map of another size: lights are then as they were
   Cost    O(texels + k^2), and O(texels) for each light that begins anew, of its stratum only. Memory: 32 bytes a texel
           meanwhile, 37 with split_sun */

ENVSH_DEF envsh_result envsh_match(const envsh_light *previous, uint32_t previous_count, envsh_light *lights,
                                   uint32_t count);
/* Reorders lights of another build: the previous ones, brightest first, give place and id to the nearest light that is
   left; of more previous lights than there are now the faintest are forgotten, and whose place is beyond count takes a
   forgotten one's. The rest follow with new ids. For maps that change their size or method.
   O(previous_count x count) */

ENVSH_DEF envsh_result envsh_rotate(envsh_light *lights, uint32_t count, const float rotation[16]);
/* Turns directions and extents with the environment (paper, section 3). rotation: columns at right angles and of equal
   length within 1e-4, of length 1 within 1e-3, else ENVSH_ERR_ARGUMENT; lengths of extents do not change. */

ENVSH_DEF size_t envsh_export_gltf(const envsh_light *lights, uint32_t count, char *text, size_t size);
/* A glTF 2.0 document with a node and a KHR_lights_punctual directional light each; W/m^2 go where lux are expected.
   Numbers that are not finite become 0. Writes at most size bytes, the last one 0, and returns the bytes that all of it
   needs. text may be NULL if size is 0. Returns 0 if lights is NULL. */

/* ---- residual: what the lights leave out, off unless you ask ---- */

ENVSH_DEF envsh_result envsh_lights_residual(const envsh_lights *lights, const envsh_map *map, float *rgb);
/* Map minus lights, each light spread evenly over its stratum: 3 floats a texel, negative ones too; its integral over
   every stratum is 0 in every channel. For glossy or unshadowed detail by your own means. */

ENVSH_DEF envsh_result envsh_lights_residual_sh(const envsh_lights *lights, const envsh_map *map, float sh[27]);
/* Map minus lights as directions, in 9 spherical harmonics x 3 channels (sh[3 j + channel]); those of j = 0 are 0 but
   for rounding, since energy is exact. envsh_sh_irradiance of it makes unshadowed shading exact to that order. */

ENVSH_DEF void envsh_sh_irradiance(const float sh[27], const float normal[3], float rgb[3]);
/* Irradiance of a surface with that unit normal, W/m^2; may be negative for a residual. */

/* ---- shadow maps ---- */

typedef struct envsh_mesh {
    const float    *positions;      /* x, y, z of each vertex */
    size_t          vertex_count;
    size_t          vertex_stride;  /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const uint32_t *indices;        /* three to a triangle; NULL = 0, 1, 2, ... */
    size_t          index_count;    /* a multiple of 3 (ignored without indices: vertex_count is used) */
} envsh_mesh;

typedef struct envsh_bounds { float low[3], high[3]; } envsh_bounds;    /* of the casters, world space */

ENVSH_DEF envsh_bounds envsh_bounds_of(const envsh_mesh *meshes, size_t count, const float *transforms);
/* Of all finite vertices. transforms: 16 floats each, mesh to world, affine; NULL = identity. low > high: none. */

typedef struct envsh_maps_desc {
    uint32_t map_size;              /* texels a side of a tile, guard included, 16..4096; 0 = 256 */
    uint32_t guard;                 /* empty texels on each side, 1..map_size / 4; 0 = 4 */
    uint32_t max_side;              /* of the atlas texture, map_size..32768; 0 = 8192. Further tiles go to pages */
    int      rgba;                  /* not 0: four tiles share a texel's channels */
    int      no_depth;              /* not 0: layout and matrices only, for maps that your GPU renders */
    int      clip_zero_to_one;      /* envsh_view.clip: not 0: z is 0..1 (Direct3D, Metal, Vulkan); 0: -1..1 (OpenGL) */
    int      clip_top_first;        /* of your textures: not 0: row 0 is at clip y = +1 (Direct3D, Metal); 0: at clip
                                       y = -1 (OpenGL, Vulkan) */
    envsh_allocator    allocator;
    envsh_parallel_for parallel_for;       /* NULL = this thread alone; results are the same */
    void              *parallel_user;
    envsh_progress     progress;           /* of each envsh_maps_draw, _shade, _visible; NULL = none.
                                              envsh_illuminate */
    void              *progress_user;      /* counts as one: shading advances, draws only ask whether to go on */
} envsh_maps_desc;

typedef struct envsh_view {         /* one light's shadow map: what your renderer or shader needs of it */
    float    clip[16];              /* world to clip space of the tile's viewport */
    float    lookup[12];            /* rows of 4: world to x and y in texels of the tile (0 = its edge), and depth */
    float    right[3], up[3];       /* unit axes of the tile, at right angles to the direction */
    float    direction[3], irradiance[3];
    float    texel[2];              /* world size of a texel, in x and y */
    float    depth_range;           /* world distance of depth 0..1 */
    float    spread[4];             /* extent: axis_u's x, y and axis_v's x, y, in texels for a blocker depth 1 away */
    uint32_t x, y, page, channel;   /* of the tile in the atlas: texels of its corner */
} envsh_view;

typedef struct envsh_atlas {
    uint32_t width, height, pages, channels;   /* channels: 1 or 4 */
    uint32_t map_size, guard, capacity;
    float   *depth;                 /* channels floats a texel, row by row, page by page; NULL with no_depth */
    size_t   bytes;                 /* all that the object keeps */
} envsh_atlas;

typedef struct envsh_maps envsh_maps;

ENVSH_DEF envsh_result envsh_maps_create(const envsh_maps_desc *desc, uint32_t capacity, envsh_maps **out);
/* capacity  lights held at once: all k (the paper's algorithm 1), or a cluster of c (its algorithm 2, envsh_illuminate)
   Errors    ENVSH_ERR_ARGUMENT, ENVSH_ERR_DESC, ENVSH_ERR_LIMIT, ENVSH_ERR_ALLOC; capacity 0 is allowed */

ENVSH_DEF void envsh_maps_free(envsh_maps *maps);           /* accepts NULL */
ENVSH_DEF void envsh_maps_atlas(const envsh_maps *maps, envsh_atlas *out);
ENVSH_DEF const envsh_view *envsh_maps_views(const envsh_maps *maps, uint32_t *count);

ENVSH_DEF envsh_result envsh_maps_begin(envsh_maps *maps, const envsh_light *lights, uint32_t count,
                                        envsh_bounds bounds);
/* Clears all tiles and fits them to bounds: sizes go in steps of a sixteenth and corners on whole texels, so that small
   changes of the bounds move no texel of a resting light. Casters outside are cut, those nearer to the light kept.
   Errors  ENVSH_ERR_ARGUMENT: count above capacity; a light that is not finite, has a direction whose length is not 1
           within 1e-3, or an axis of 1e3 or more; bounds not finite or beyond 1e15
   Empty bounds: nothing casts shadows */

ENVSH_DEF envsh_result envsh_maps_draw(envsh_maps *maps, const envsh_mesh *mesh, const float transform[16]);
/* Renders the depth of a mesh into every tile: texel centres, top-left rule, both sides. NULL = identity. Triangles
   with a vertex that is not finite are left out.
   Errors  ENVSH_ERR_ARGUMENT, ENVSH_ERR_MESH, ENVSH_ERR_ORDER; ENVSH_ERR_DESC with no_depth; ENVSH_ERR_CANCELLED: some
           tiles have the mesh, others not; begin anew */

ENVSH_DEF envsh_result envsh_maps_set(envsh_maps *maps, uint32_t light, const float *depth, size_t row_stride);
/* A tile from your own renderer: map_size rows of map_size depths, row 0 at y = 0; row_stride in bytes, 0 = packed.
   The guard is kept empty whatever is given. NaN counts as nothing there. */

ENVSH_DEF envsh_result envsh_maps_end(envsh_maps *maps);
/* All is drawn: makes the depth bounds of cells that shading needs. A later draw or set asks for another end. */

/* ---- shading ---- */

typedef enum envsh_filter {
    ENVSH_FILTER_PLAIN,             /* one texel */
    ENVSH_FILTER_SMOOTH,            /* the paper's smoothing: all texels within radius, weights falling linearly */
    ENVSH_FILTER_PCF,               /* the paper's percentage closer filtering: taps jittered within radius */
    ENVSH_FILTER_PENUMBRA,          /* taps within the penumbra: extent x distance to the blockers found */
    ENVSH_FILTER_COUNT
} envsh_filter;

#define ENVSH_MAX_TAPS 64u

typedef struct envsh_query {
    const float *points;            /* x, y, z of each receiver, world space */
    const float *normals;           /* unit shading normals: the cosine. Not made unit: length 2 doubles the light */
    const float *geometric;         /* unit normals of the surface itself: offsets, which side it is; NULL = normals */
    size_t       point_stride, normal_stride, geometric_stride;     /* bytes, multiples of 4, >= 12; 0 = 12 */
    size_t       count;
    envsh_filter filter;
    uint32_t     taps;              /* PCF, PENUMBRA: 1..ENVSH_MAX_TAPS */
    float        radius;            /* SMOOTH: 0.5..8 texels; PCF: 0..32; PENUMBRA: most texels, 0..64 */
    float        bias;              /* texels along the geometric normal at grazing light, >= 0 */
    float        extent_scale;      /* PENUMBRA: factor on the strata's extents, >= 0 */
    uint32_t     seed;              /* of the taps' rotation; point i draws from (seed, first + i) */
    uint32_t     first;
    int          add;               /* not 0: adds to the output */
} envsh_query;

ENVSH_DEF envsh_query envsh_query_default(void);
/* All zero but filter PENUMBRA, 16 taps, radius 12, bias 1, extent_scale 1. SMOOTH refuses that radius: set both. */

ENVSH_DEF envsh_result envsh_shade(const envsh_maps *maps, const envsh_query *query, float *irradiance);
/* For each point the sum over all lights of visibility x cosine x irradiance: 3 floats, W/m^2; times albedo / pi it is
   the radiance of a diffuse surface. Points or normals that are not finite give 0.
   Errors  ENVSH_ERR_ARGUMENT; ENVSH_ERR_DESC with no_depth; ENVSH_ERR_ORDER; ENVSH_ERR_CANCELLED: some points may be
           done */

ENVSH_DEF envsh_result envsh_visible(const envsh_maps *maps, uint32_t light, const envsh_query *query, float *visible);
/* Visibility of one light, 0..1, for your own BRDF. 0 behind the geometric surface; query->add is ignored. */

ENVSH_DEF float envsh_visibility_twin(const envsh_view *view, const float *depth, size_t row_floats,
                                      size_t texel_floats, uint32_t map_size, const envsh_query *query,
                                      const float point[3], const float geometric[3], uint32_t index);
/* The C twin of the GLSL function: one point, one tile (depth: its corner texel and channel), without the shortcut of
   cells that envsh_visible takes. Same answers; 0 where a pointer is NULL or the query is one that envsh_visible
   refuses. */

typedef envsh_result (*envsh_draw)(void *user, envsh_maps *maps);
/* Calls envsh_maps_draw or envsh_maps_set for everything that casts shadows. */

ENVSH_DEF envsh_result envsh_illuminate(envsh_maps *maps, const envsh_light *lights, uint32_t count,
                                        envsh_bounds bounds, envsh_draw draw, void *user, const envsh_query *query,
                                        float *irradiance);
/* The paper's algorithm 2: for each cluster of capacity lights, draws their maps and adds their light. With a capacity
   of count or more it is algorithm 1. The same sums, to the bit, for every capacity.
   Errors  those of envsh_maps_begin, envsh_shade (of the query before anything is drawn) and draw */

/* ---- how many lights a pass: the cost model ---- */

typedef struct envsh_cost {         /* milliseconds of a frame with clusters of c: passes = ceil(k / c) */
    double pass;                    /* each pass, whatever it holds: state, geometry, fetching the surface */
    double slot;                    /* each of the passes x c places for a light, filled or not */
} envsh_cost;

ENVSH_DEF int envsh_cost_fit(uint32_t light_count, const uint32_t *sizes, const double *ms, size_t count,
                             envsh_cost *out);
/* Least squares through times measured with clusters of sizes[i]; two different ones or more. 0: cannot be fitted. */

ENVSH_DEF uint32_t envsh_cluster_size(const envsh_cost *cost, uint32_t light_count, uint32_t most);
/* The c of 1..most with the least passes x pass + passes x c x slot; among equals the smallest, which needs the least
   memory. most: what your atlas, uniforms or instruction limit allow. */

#ifdef __cplusplus
}
#endif

#endif /* ENVSHADOW_H */

/* ==== implementation ============================================================================================== */

#if defined(ENVSHADOW_IMPLEMENTATION) && !defined(ENVSHADOW_IMPLEMENTED)
#define ENVSHADOW_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* >>> shared fp_begin mem v3 m4 trig rng cdf batch: written by tools/stamp from src/shared, edit there */

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

/* *out = a * b and 1, or 0 and *out untouched where the product does not fit. */
static inline int envsh__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

/* Takes the members of a public desc. Both functions or none: valid() is what the desc check asks. */
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

/* NULL where the size is 0 or overflows, so that a caller has one thing to test. */
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

static inline envsh__v3 envsh__v3_add(envsh__v3 a, envsh__v3 b)
{
    return envsh__v3_make(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline envsh__v3 envsh__v3_sub(envsh__v3 a, envsh__v3 b)
{
    return envsh__v3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline envsh__v3 envsh__v3_scale(envsh__v3 a, float s)
{
    return envsh__v3_make(a.x * s, a.y * s, a.z * s);
}

/* a + b s */
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

static inline envsh__v3 envsh__v3_cross(envsh__v3 a, envsh__v3 b)
{
    return envsh__v3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/* Scaled by the largest component first, so that neither tiny nor huge vectors leave the float range.
   The zero vector stays zero. */
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

/* By the exponent bits, because compilers may take isfinite() for always true under -ffast-math. */
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

/* b1, b2, n right-handed and orthonormal for a unit n. Duff et al., "Building an orthonormal basis, revisited",
   JCGT 6(1), 2017; n.z = -0 and n.z = -1 included. */
static inline void envsh__v3_basis(envsh__v3 n, envsh__v3 *b1, envsh__v3 *b2)
{
    float s = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + n.z), b = n.x * n.y * a;
    *b1 = envsh__v3_make(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
    *b2 = envsh__v3_make(b, s + n.y * n.y * a, -n.y);
}

/* unit m4, needs v3: column-major 4 x 4 matrices, float[16], affine */

static inline envsh__v3 envsh__m4_point(const float *m, envsh__v3 p)
{
    return envsh__v3_make(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12], m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                     m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]);
}

static inline envsh__v3 envsh__m4_direction(const float *m, envsh__v3 d)
{
    return envsh__v3_make(m[0] * d.x + m[4] * d.y + m[8] * d.z, m[1] * d.x + m[5] * d.y + m[9] * d.z,
                     m[2] * d.x + m[6] * d.y + m[10] * d.z);
}

/* Finite, with 0 0 0 1 as its last row. */
static inline int envsh__m4_is_affine(const float *m)
{
    int i;
    for (i = 0; i < 16; i++)
        if (!envsh__finite(m[i])) return 0;
    return m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f && m[15] == 1.0f;
}

/* 1 and *scale where m is a rotation times one scale > 0 (no mirroring) plus a translation: columns of equal length
   and at right angles within 1e-4, which is what products of float rotations reach. */
static inline int envsh__m4_is_rigid_uniform(const float *m, float *scale)
{
    envsh__v3 x = envsh__v3_load(m), y = envsh__v3_load(m + 4), z = envsh__v3_load(m + 8);
    float s, lx, ly, lz, tolerance;

    if (!envsh__m4_is_affine(m)) return 0;
    lx = envsh__v3_length(x);
    ly = envsh__v3_length(y);
    lz = envsh__v3_length(z);
    if (!(lx > 0.0f && ly > 0.0f && lz > 0.0f) || !envsh__finite(lx + ly + lz)) return 0;
    s = (lx + ly + lz) / 3.0f;
    tolerance = 1e-4f * s;
    if (fabsf(lx - s) > tolerance || fabsf(ly - s) > tolerance || fabsf(lz - s) > tolerance) return 0;
    x = envsh__v3_scale(x, 1.0f / lx);
    y = envsh__v3_scale(y, 1.0f / ly);
    z = envsh__v3_scale(z, 1.0f / lz);
    if (fabsf(envsh__v3_dot(x, y)) > 1e-4f || fabsf(envsh__v3_dot(x, z)) > 1e-4f) return 0;
    if (fabsf(envsh__v3_dot(y, z)) > 1e-4f || envsh__v3_dot(envsh__v3_cross(x, y), z) < 0.0f) return 0;
    *scale = s;
    return 1;
}

/* unit trig: elementary functions with the same bits on every machine */

/* Only + - * / and sqrt, which IEEE 754 rounds the same everywhere as long as nothing is contracted (unit fp_begin).
   Coefficients are minimax fits of our own. The float functions are free of branches and calls, so that loops over
   them vectorise at SSE2 level. Errors named below are the largest against the double functions, all float arguments or
   a dense set tried (tests/unit/shared_test.c). Out of range or NaN is clamped into the range, so that nothing here is
   undefined or returns NaN. */

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

/* |x| with the sign bit of s; s = -0 counts as negative. */
static inline float envsh__copysign(float x, float s)
{
    return envsh__from_bits((envsh__to_bits(x) & 0x7fffffffu) | (envsh__to_bits(s) & 0x80000000u));
}

/* a where yes is 1, b where it is 0, both computed: compilers turn a chain of ?: with one condition into a branch, and
   then do not vectorise the loop round it. */
static inline float envsh__either(int yes, float a, float b)
{
    uint32_t mask = 0u - (uint32_t)yes;
    return envsh__from_bits((envsh__to_bits(a) & mask) | (envsh__to_bits(b) & ~mask));
}

/* Cody and Waite: pi/2 in three parts, of which the first two times k are exact for |k| < 2^13. |x| <= 8192: error 1e-7
   absolute. */
static inline void envsh__sincos(float x, float *sine, float *cosine)
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

static inline float envsh__cos(float x)
{
    float s, c;
    envsh__sincos(x, &s, &c);
    return c;
}

/* asin of 0 <= x <= 0.5, z = x * x. What is made of it: error 3e-7 absolute. */
static inline float envsh__asin_core(float x, float z)
{
    return x + x * z * (0.1666675393f + z * (0.07495241769f + z * (0.04547709903f + z * (0.02414760004f +
                        z * 0.04221856856f))));
}

/* Above a half by asin(x) = pi/2 - 2 asin(sqrt((1 - x) / 2)), which keeps acos exact near 0. The square root apart,
   since C compilers do not vectorise that one: acos(x) = envsh__acos_rooted(x, sqrtf(envsh__acos_square(x))). */
static inline float envsh__acos_square(float x)
{
    float a = fabsf(x);
    return 0.5f * (1.0f - envsh__either(a < 1.0f, a, 1.0f));
}

static inline float envsh__acos_rooted(float x, float root)
{
    float a = fabsf(x), h = envsh__acos_square(x), p;
    int big = a > 0.5f;
    a = envsh__either(a < 1.0f, a, 1.0f);
    p = envsh__asin_core(envsh__either(big, root, a), envsh__either(big, h, a * a));
    p = envsh__either(big, 2.0f * p, 1.57079633f - p);
    return envsh__either(x < 0.0f, 3.14159265f - p, p);
}

static inline float envsh__acos(float x) { return envsh__acos_rooted(x, sqrtf(envsh__acos_square(x))); }

static inline float envsh__asin(float x)
{
    float a = fabsf(x), h, s, p;
    a = a < 1.0f ? a : 1.0f;
    h = 0.5f * (1.0f - a);
    s = sqrtf(h);
    s = a > 0.5f ? s : a;
    p = envsh__asin_core(s, a > 0.5f ? h : a * a);
    return envsh__copysign(a > 0.5f ? 1.57079633f - 2.0f * p : p, x);
}

/* unit rng: hashes and random numbers, the same on every machine */

/* Jarzynski and Olano, "Hash functions for GPU rendering", JCGT 9(3), 2020: the output function of O'Neill's PCG. */
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

/* The upper 24 bits: every value is a float, the largest is 1 - 2^-24. */
static inline float envsh__to_unit(uint32_t bits) { return (float)(bits >> 8) * (1.0f / 16777216.0f); }

/* unit cdf: piecewise-constant distributions in 1D and 2D, sampled by inversion */

/* Running sums in double: a float sum of 1e6 small weights is wrong in the third digit. sums[i] is the weight before
   cell i, sums[count] the total; the array is the caller's. */
typedef struct envsh__cdf { const double *sums; uint32_t count; } envsh__cdf;

typedef struct envsh__cdf_sample {
    uint32_t index;
    float    fraction;      /* where u fell inside the cell, [0, 1): a fresh random number */
    float    probability;   /* of the cell; 0 only where all weights are 0 */
} envsh__cdf_sample;

static inline double envsh__cdf_total(const envsh__cdf *cdf) { return cdf->sums[cdf->count]; }

/* The cell with sums[i] <= u * total < sums[i + 1]: the strict upper bound is what keeps empty cells out, also at
   u = 0, and u below 1 in range. u outside [0, 1) is clamped. */
static inline envsh__cdf_sample envsh__cdf_sample_at(const envsh__cdf *cdf, float u)
{
    envsh__cdf_sample s;
    double total = envsh__cdf_total(cdf), x, width, f;
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
    /* Only where x rounded up to a total of denormal size. */
    while (lo > 0 && !(cdf->sums[lo + 1u] > cdf->sums[lo])) lo--;
    width = cdf->sums[lo + 1u] - cdf->sums[lo];
    f = (x - cdf->sums[lo]) / width;
    s.index = lo;
    s.fraction = f < 0.99999994 ? (float)f : 0.99999994f;
    s.probability = (float)(width / total);
    return s;
}

/* unit batch: tasks of a call, some at a time */

typedef struct envsh__batch { void (*task)(void *context, size_t index); void *context; size_t first; } envsh__batch;

/* A task itself; context: the batch. */
static inline void envsh__batch_task(void *context, size_t index)
{
    const envsh__batch *b = (const envsh__batch *)context;
    b->task(b->context, b->first + index);
}

/* <<< shared */

/* ---- >>math: sine, cosine and arc tangent in double, the same bits everywhere ---- */

#define ENVSH__PI 3.14159265358979324

/* Taylor series over an eighth of a turn; |x| <= 100. */
static void envsh__sincos64(double x, double *sine, double *cosine)
{
    int k = (int)(x * (2.0 / ENVSH__PI) + (x < 0.0 ? -0.5 : 0.5)), j;
    double r = (x - (double)k * 1.5707963267948966) - (double)k * 6.123233995736766e-17, z = r * r, s = 1.0, c = 1.0;
    for (j = 9; j > 0; j--) {
        s = 1.0 - s * z / (double)(2 * j * (2 * j + 1));
        c = 1.0 - c * z / (double)(2 * j * (2 * j - 1));
    }
    s *= r;
    *sine = k & 2 ? -(k & 1 ? c : s) : k & 1 ? c : s;
    *cosine = (k + 1) & 2 ? -(k & 1 ? s : c) : k & 1 ? s : c;
}

/* atan x = 4 atan(x''), each ' by tan(a / 2) = tan a / (1 + sqrt(1 + tan^2 a)). */
static double envsh__atan64(double x)
{
    double y = x / (1.0 + sqrt(1.0 + x * x)), z, sum = 0.0;
    int j;
    y = y / (1.0 + sqrt(1.0 + y * y));
    z = y * y;
    for (j = 21; j >= 0; j--) sum = 1.0 / (double)(2 * j + 1) - z * sum;
    return 4.0 * y * sum;
}

/* ---- >>texels: directions and solid angles ---- */

/* Of the rectangle from the face's centre to (a, b), the face being at distance 1. */
static double envsh__corner(double a, double b) { return envsh__atan64(a * b / sqrt(1.0 + a * a + b * b)); }

static double envsh__rectangle(double a0, double a1, double b0, double b1)
{
    return envsh__corner(a1, b1) - envsh__corner(a0, b1) - envsh__corner(a1, b0) + envsh__corner(a0, b0);
}

/* The part of a texel above the horizon, or all of it. */
static double envsh__solid_angle(const envsh_map *map, uint32_t face, uint32_t x, uint32_t y, int upper)
{
    double w = map->width, h = map->height, c0, c1, s, b0, b1;
    if (map->projection != ENVSH_MAP_CUBE) {
        envsh__sincos64(ENVSH__PI * y / h, &s, &c0);
        envsh__sincos64(ENVSH__PI * (y + 1.0) / h, &s, &c1);
        if (upper && 2 * (uint64_t)y >= map->height) return 0.0;
        if (upper && 2 * ((uint64_t)y + 1) > map->height) c1 = 0.0;
        return 2.0 * ENVSH__PI / w * (c0 - c1);
    }
    b0 = 2.0 * y / h - 1.0;
    b1 = 2.0 * (y + 1.0) / h - 1.0;
    if (upper && face == 3) return 0.0;
    if (upper && face != 2) b1 = b1 > 0.0 ? 0.0 : b1;
    if (b0 >= b1) return 0.0;
    return envsh__rectangle(2.0 * x / w - 1.0, 2.0 * (x + 1.0) / w - 1.0, b0, b1);
}

static void envsh__cube_direction(uint32_t face, double a, double b, double *d)
{
    double length = 1.0 / sqrt(1.0 + a * a + b * b);
    double x = face == 0 ? 1.0 : face == 1 ? -1.0 : face == 5 ? -a : a;
    double y = face == 2 ? 1.0 : face == 3 ? -1.0 : -b;
    double z = face == 0 ? -a : face == 1 ? a : face == 2 ? b : face == 3 ? -b : face == 4 ? 1.0 : -1.0;
    d[0] = x * length;
    d[1] = y * length;
    d[2] = z * length;
}

static void envsh__direction(const envsh_map *map, uint32_t face, double x, double y, double *d)
{
    double st, ct, sp, cp;
    if (map->projection == ENVSH_MAP_CUBE) {
        envsh__cube_direction(face, 2.0 * x / map->width - 1.0, 2.0 * y / map->height - 1.0, d);
        return;
    }
    envsh__sincos64(ENVSH__PI * y / map->height, &st, &ct);
    envsh__sincos64(2.0 * ENVSH__PI * (x / map->width - 0.5), &sp, &cp);
    d[0] = st * cp;
    d[1] = ct;
    d[2] = st * sp;
}

/* The texel of a face, or of the neighbouring face where x or y is one beyond it. */
static uint32_t envsh__cube_texel(uint32_t side, uint32_t face, int64_t x, int64_t y)
{
    double d[3], m[3], a, b, n = side;
    int64_t col = x, row = y;
    int i, axis = 0;
    if (x < 0 || y < 0 || x >= (int64_t)side || y >= (int64_t)side) {
        envsh__cube_direction(face, (2.0 * (double)x + 1.0) / n - 1.0, (2.0 * (double)y + 1.0) / n - 1.0, d);
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

static envsh_result envsh__check_map(const envsh_map *map, size_t *texels)
{
    uint64_t count;
    if (!map->rgb || !map->width || !map->height) return ENVSH_ERR_MAP;
    if ((unsigned)map->projection >= ENVSH_PROJECTION_COUNT) return ENVSH_ERR_MAP;
    if (map->projection == ENVSH_MAP_CUBE && map->width != map->height) return ENVSH_ERR_MAP;
    if (map->texel_stride && (map->texel_stride < 12 || map->texel_stride % 4)) return ENVSH_ERR_MAP;
    if (map->width > 1u << 27 || map->height > 1u << 27) return ENVSH_ERR_LIMIT;
    count = (uint64_t)map->width * map->height * (map->projection == ENVSH_MAP_CUBE ? 6u : 1u);
    if (count > 1u << 27) return ENVSH_ERR_LIMIT;
    if (map->texel_stride && (size_t)count > SIZE_MAX / map->texel_stride) return ENVSH_ERR_LIMIT;
    *texels = (size_t)count;
    return ENVSH_OK;
}

/* A texel's radiance, made fit for sums: 1 where a channel had to be replaced. As integers, negative values, NaN and
   what is above 1e30 are all greater than 1e30; -0 is greater too, but not bad. */
static inline int envsh__fetch(const envsh_map *map, size_t texel, float *rgb)
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

static float envsh__luminance(const float *rgb)
{
    return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
}

/* ---- >>grid: the map as weights, its columns turned so that the least energy comes first ---- */

typedef struct envsh__grid {
    envsh_map map;
    uint32_t  width, height, faces, roll;   /* map column of the grid's column 0 */
    size_t    count;
    float    *lum;                          /* luminance; 0 where a texel does not count or belongs to the sun */
    float    *omega;                        /* solid angle that counts */
    float    *dx, *dy, *dz;                 /* unit directions, columns counted from the roll */
    double    total;                        /* luminance x solid angle */
    uint64_t  bad;
    float    *memory;
} envsh__grid;

/* Texel of the map for column x of the row that begins at texel `row`. */
static size_t envsh__map_texel(const envsh__grid *g, size_t row, uint32_t x)
{
    return row + (x < g->width - g->roll ? x + g->roll : x + g->roll - g->width);
}

static void envsh__fill_directions(envsh__grid *g)
{
    uint32_t f, x, y;
    double d[3], st, ct, sp, cp;
    size_t t = 0;
    if (g->faces == 6) {
        for (f = 0; f < 6; f++)
            for (y = 0; y < g->height; y++)
                for (x = 0; x < g->width; x++, t++) {
                    envsh__direction(&g->map, f, x + 0.5, y + 0.5, d);
                    g->dx[t] = (float)d[0];
                    g->dy[t] = (float)d[1];
                    g->dz[t] = (float)d[2];
                }
        return;
    }
    for (x = 0; x < g->width; x++) {        /* the first row holds the azimuths until its own turn comes last */
        envsh__sincos64(2.0 * ENVSH__PI * (x + 0.5) / g->width, &sp, &cp);
        g->dx[x] = (float)cp;
        g->dz[x] = (float)sp;
    }
    for (y = g->height; y-- > 0;) {
        envsh__sincos64(ENVSH__PI * (y + 0.5) / g->height, &st, &ct);
        t = (size_t)y * g->width;
        for (x = 0; x < g->width; x++) {
            g->dx[t + x] = (float)st * g->dx[x];
            g->dy[t + x] = (float)ct;
            g->dz[t + x] = (float)st * g->dz[x];
        }
    }
}

/* Column sums of a latitude-longitude map decide where it is cut open (T21). sums: width doubles, zeroed. */
static void envsh__choose_roll(envsh__grid *g, double *sums, int hemisphere)
{
    uint32_t x, y;
    float rgb[3];
    for (y = 0; y < g->height; y++) {
        double omega = envsh__solid_angle(&g->map, 0, 0, y, hemisphere);
        for (x = 0; omega > 0.0 && x < g->width; x++) {
            envsh__fetch(&g->map, (size_t)y * g->width + x, rgb);
            sums[x] += (double)envsh__luminance(rgb) * omega;
        }
    }
    for (x = 0; x < g->width; x++)
        if (sums[x] < sums[g->roll]) g->roll = x;
}

static void envsh__fill_weights(envsh__grid *g, int hemisphere)
{
    uint32_t f, x, y;
    size_t t = 0;
    float rgb[3];
    for (f = 0; f < g->faces; f++)
        for (y = 0; y < g->height; y++) {
            double row = 0.0, omega = g->faces == 1 ? envsh__solid_angle(&g->map, 0, 0, y, hemisphere) : 0.0;
            for (x = 0; x < g->width; x++, t++) {
                if (g->faces == 6) omega = envsh__solid_angle(&g->map, f, x, y, hemisphere);
                g->omega[t] = (float)omega;
                g->lum[t] = 0.0f;
                if (!(omega > 0.0)) continue;
                g->bad += (uint64_t)envsh__fetch(&g->map, envsh__map_texel(g, t - x, x), rgb);
                g->lum[t] = envsh__luminance(rgb);
                row += (double)g->lum[t] * omega;
            }
            g->total += row;
        }
}

/* roll: ENVSH_NO_LIGHT = the column of least energy. */
static envsh_result envsh__grid_make(envsh__grid *g, const envsh_map *map, int hemisphere, uint32_t roll,
                                     const envsh__allocator *a)
{
    double *sums;
    size_t t, count = 0;
    envsh_result result = envsh__check_map(map, &count);
    if (result != ENVSH_OK) return result;
    memset(g, 0, sizeof *g);
    g->map = *map;
    g->width = map->width;
    g->height = map->height;
    g->faces = map->projection == ENVSH_MAP_CUBE ? 6 : 1;
    g->count = count;
    g->roll = roll == ENVSH_NO_LIGHT ? 0 : roll;
    if (g->faces == 1 && roll == ENVSH_NO_LIGHT) {
        sums = (double *)envsh__alloc_array(a, g->width, sizeof *sums);
        if (!sums) return ENVSH_ERR_ALLOC;
        for (t = 0; t < g->width; t++) sums[t] = 0.0;
        envsh__choose_roll(g, sums, hemisphere);
        envsh__free(a, sums);
    }
    g->memory = (float *)envsh__alloc_array(a, g->count, 5 * sizeof(float));
    if (!g->memory) return ENVSH_ERR_ALLOC;
    g->lum = g->memory;
    g->omega = g->lum + count;
    g->dx = g->omega + count;
    g->dy = g->dx + count;
    g->dz = g->dy + count;
    envsh__fill_directions(g);
    envsh__fill_weights(g, hemisphere);
    return ENVSH_OK;
}

static double envsh__weight(const envsh__grid *g, size_t t) { return (double)g->lum[t] * (double)g->omega[t]; }

static double envsh__total(const envsh__grid *g)
{
    double total = 0.0;
    size_t t;
    for (t = 0; t < g->count; t++) total += envsh__weight(g, t);
    return total;
}

/* The four neighbours of a texel: round the seam and over the poles, or across the cube's edges. */
static void envsh__neighbours(const envsh__grid *g, uint32_t t, uint32_t *out)
{
    uint32_t w = g->width, h = g->height, x = t % w, row = t / w, y = row % h, face = row / h;
    if (g->faces == 6) {
        out[0] = x > 0 ? t - 1 : envsh__cube_texel(w, face, -1, (int64_t)y);
        out[1] = x + 1 < w ? t + 1 : envsh__cube_texel(w, face, (int64_t)w, (int64_t)y);
        out[2] = y > 0 ? t - w : envsh__cube_texel(w, face, (int64_t)x, -1);
        out[3] = y + 1 < h ? t + w : envsh__cube_texel(w, face, (int64_t)x, (int64_t)h);
        return;
    }
    out[0] = x > 0 ? t - 1 : t + w - 1;
    out[1] = x + 1 < w ? t + 1 : t + 1 - w;
    out[2] = y > 0 ? t - w : row * w + (x + w / 2) % w;
    out[3] = y + 1 < h ? t + w : row * w + (x + w / 2) % w;
}

/* ---- >>structured: structured importance sampling ---- */

/* Agarwal, Ramamoorthi, Belongie and Jensen, "Structured importance sampling of environment maps", SIGGRAPH 2003.
   Thresholds i sigma, i = 5 .. 0, cut the map into layers. From the brightest down, each connected region gets
   N L min(w, w0)^(1/4) / (L_all w0^(1/4)) samples, w0 = 0.01 sr: beyond it visibility is as good as uncorrelated, so
   that size counts no more. Samples that it holds from brighter layers are counted in; the others are spread by
   Hochbaum and Shmoys' farthest-first traversal. A texel belongs to the nearest sample of the innermost region that
   got samples of its own. */
#define ENVSH__LAYERS 6u
#define ENVSH__BLOCK 8u
#define ENVSH__FROZEN 0x80u
#define ENVSH__SAMPLE 0x40u

typedef struct envsh__block {
    float    center[3], radius;             /* cone of its texels' directions */
    float    skip;                          /* a sample at this cosine or less from the centre changes nothing here */
    float    worst;                         /* least cosine of a candidate to its sample */
    uint32_t worst_texel;
    uint32_t face, x0, y0, x1, y1;
} envsh__block;

typedef struct envsh__structured {
    const envsh__grid *g;
    float        *best;                     /* cosine to the nearest sample of the region at hand */
    uint32_t     *label, *owner, *queue;    /* owner: region that a texel is in */
    uint8_t      *layer;
    uint32_t     *sample;                   /* texel of each sample */
    uint32_t      count, wanted, region;
    envsh__block *blocks;
    uint32_t      block_count, blocks_wide, blocks_high;
} envsh__structured;

static void envsh__make_blocks(envsh__structured *s)
{
    const envsh__grid *g = s->g;
    uint32_t b, x, y;
    for (b = 0; b < s->block_count; b++) {
        envsh__block *k = &s->blocks[b];
        envsh__v3 sum = envsh__v3_make(0, 0, 0);
        float least = 1.0f, c;
        k->face = b / (s->blocks_wide * s->blocks_high);
        k->x0 = b % s->blocks_wide * ENVSH__BLOCK;
        k->y0 = b / s->blocks_wide % s->blocks_high * ENVSH__BLOCK;
        k->x1 = k->x0 + ENVSH__BLOCK < g->width ? k->x0 + ENVSH__BLOCK : g->width;
        k->y1 = k->y0 + ENVSH__BLOCK < g->height ? k->y0 + ENVSH__BLOCK : g->height;
        for (y = k->y0; y < k->y1; y++)
            for (x = k->x0; x < k->x1; x++) {
                size_t t = ((size_t)k->face * g->height + y) * g->width + x;
                sum = envsh__v3_add(sum, envsh__v3_make(g->dx[t], g->dy[t], g->dz[t]));
            }
        sum = envsh__v3_normalize(sum);
        envsh__v3_store(k->center, sum);
        for (y = k->y0; y < k->y1; y++)
            for (x = k->x0; x < k->x1; x++) {
                size_t t = ((size_t)k->face * g->height + y) * g->width + x;
                c = sum.x * g->dx[t] + sum.y * g->dy[t] + sum.z * g->dz[t];
                if (c < least) least = c;
            }
        k->radius = envsh__acos(least) + 1e-3f;
    }
}

/* The sample against every texel of the block; then which candidate is worst off, and which samples are too far to
   change anything. A texel that is a sample itself, or no candidate, has best = 2. */
static void envsh__update_block(const envsh__structured *s, envsh__block *k, uint32_t id)
{
    const envsh__grid *g = s->g;
    uint32_t at = s->sample[id], y;
    float cx = g->dx[at], cy = g->dy[at], cz = g->dz[at], farthest = 2.0f, reach;
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
    reach = (farthest > 1.0f ? 0.0f : envsh__acos(farthest)) + k->radius;
    k->skip = farthest > 1.5f ? 2.0f : reach < 3.14f ? envsh__cos(reach) - 1e-5f : -2.0f;
}

static void envsh__add_sample(envsh__structured *s, uint32_t id)
{
    const envsh__grid *g = s->g;
    uint32_t at = s->sample[id], b;
    for (b = 0; b < s->block_count; b++) {
        envsh__block *k = &s->blocks[b];
        if (g->dx[at] * k->center[0] + g->dy[at] * k->center[1] + g->dz[at] * k->center[2] > k->skip)
            envsh__update_block(s, k, id);
    }
}

/* Samples of brighter layers that crowd together count as one outside their region: is there an earlier one within two
   degrees? Without this a sun's hundred samples would each have to be tried on the whole sky. */
static int envsh__has_twin(const envsh__structured *s, uint32_t id)
{
    const envsh__grid *g = s->g;
    uint32_t a = s->sample[id], b, i;
    for (i = 0; i < id; i++) {
        b = s->sample[i];
        if (s->owner[b] != s->region) continue;
        if (g->dx[a] * g->dx[b] + g->dy[a] * g->dy[b] + g->dz[a] * g->dz[b] > 0.99939f) return 1;
    }
    return 0;
}

/* Farthest-first within the region whose texels are queue[0..size), or all texels for size 0. */
static void envsh__spread(envsh__structured *s, uint32_t size, uint32_t brightest, uint32_t fresh)
{
    uint32_t i, b, n = size ? size : (uint32_t)s->g->count, before = s->count, last = before + fresh;
    for (b = 0; b < s->block_count; b++) s->blocks[b].skip = size ? 2.0f : -2.0f;
    for (b = 0; b < s->block_count; b++) s->blocks[b].worst = 2.0f;
    for (i = 0; i < n; i++) {
        uint32_t t = size ? s->queue[i] : i, row = t / s->g->width;
        uint32_t y = row % s->g->height / ENVSH__BLOCK, face = row / s->g->height;
        if (s->layer[t] & ENVSH__FROZEN) continue;
        s->best[t] = -2.0f;
        if (size) s->blocks[(face * s->blocks_high + y) * s->blocks_wide + t % s->g->width / ENVSH__BLOCK].skip = -2.0f;
    }
    for (i = 0; i < before; i++)
        if (s->owner[s->sample[i]] == s->region && !envsh__has_twin(s, i)) envsh__add_sample(s, i);
    while (s->count < last) {
        uint32_t at = brightest;
        float worst = 2.0f;
        for (b = 0; b < s->block_count; b++)
            if (s->blocks[b].worst < worst) {
                worst = s->blocks[b].worst;
                at = s->blocks[b].worst_texel;
            }
        if (worst > 1.5f && (s->count > before || s->layer[at] & ENVSH__FROZEN)) break;
        s->sample[s->count] = at;
        s->layer[at] |= ENVSH__SAMPLE;
        s->best[at] = 2.0f;
        s->label[at] = s->count;
        envsh__add_sample(s, s->count++);
    }
    for (i = 0; i < n; i++) {
        s->layer[size ? s->queue[i] : i] |= ENVSH__FROZEN;
        s->best[size ? s->queue[i] : i] = 2.0f;
    }
}

/* The connected region of texels in this layer or above round the texel; fills the queue and returns its size. */
static uint32_t envsh__flood(envsh__structured *s, uint32_t seed, uint32_t layer, double *energy, double *omega,
                             uint32_t *samples, uint32_t *brightest)
{
    uint32_t head = 0, tail = 0, next[4], i;
    float most = -1.0f;
    *energy = *omega = 0.0;
    *samples = 0;
    s->queue[tail++] = seed;
    s->owner[seed] = s->region;
    while (head < tail) {
        uint32_t t = s->queue[head++];
        *energy += envsh__weight(s->g, t);
        *omega += (double)s->g->omega[t];
        *samples += (s->layer[t] & ENVSH__SAMPLE) != 0;
        if (s->g->lum[t] > most && !(s->layer[t] & ENVSH__FROZEN)) {
            most = s->g->lum[t];
            *brightest = t;
        }
        envsh__neighbours(s->g, t, next);
        for (i = 0; i < 4; i++)
            if ((s->layer[next[i]] & 15u) >= layer && s->owner[next[i]] != s->region) {
                s->owner[next[i]] = s->region;
                s->queue[tail++] = next[i];
            }
    }
    return tail;
}

static void envsh__make_layers(envsh__structured *s, double *all_omega)
{
    const envsh__grid *g = s->g;
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
        while (i + 1 < ENVSH__LAYERS && sigma > 0.0 && (double)g->lum[t] >= (i + 1) * sigma) i++;
        s->layer[t] = (uint8_t)i;
        s->owner[t] = 0;
        s->label[t] = ENVSH_NO_LIGHT;
        s->best[t] = 2.0f;
    }
    *all_omega = omega;
}

static double envsh__importance(double energy, double omega)
{
    return energy * sqrt(sqrt(omega < 0.01 ? omega : 0.01));
}

static void envsh__run_structured(envsh__structured *s)
{
    const envsh__grid *g = s->g;
    double all, energy, omega;
    uint32_t layer, samples, brightest = 0, size, fresh;
    size_t t, first = 0;

    envsh__make_layers(s, &omega);
    envsh__make_blocks(s);
    all = envsh__importance(g->total, omega);
    for (layer = ENVSH__LAYERS - 1; layer > 0; layer--) {
        uint32_t oldest = s->region + 1;
        for (t = 0; t < g->count; t++) {
            double share;
            if ((s->layer[t] & 15u) < layer || s->owner[t] >= oldest) continue;
            s->region++;
            size = envsh__flood(s, (uint32_t)t, layer, &energy, &omega, &samples, &brightest);
            share = (double)s->wanted * envsh__importance(energy, omega) / all + 0.5;
            fresh = share > samples + 1.0 ? (uint32_t)share - samples : 0;
            if (fresh > s->wanted - s->count) fresh = s->wanted - s->count;
            if (fresh && !(s->layer[brightest] & ENVSH__FROZEN)) envsh__spread(s, size, brightest, fresh);
        }
    }
    s->region++;
    for (t = 0; t < g->count; t++) {
        if (!(g->omega[t] > 0.0f)) s->layer[t] |= ENVSH__FROZEN;
        else if (!(s->layer[t] & ENVSH__FROZEN) && (s->layer[first] & ENVSH__FROZEN || g->lum[t] > g->lum[first]))
            first = t;
        s->owner[t] = s->region;
    }
    envsh__spread(s, 0, (uint32_t)first, s->wanted - s->count);
}

/* Where the row of averages begins that row y of all faces belongs to. */
static size_t envsh__coarse_row(const envsh__grid *g, const envsh__grid *coarse, uint32_t factor, uint32_t y)
{
    return ((size_t)(y / g->height) * coarse->height + y % g->height / factor) * coarse->width;
}

/* Averages of factor x factor texels; what is left at the edges makes smaller ones. */
static int envsh__coarsen(const envsh__grid *g, uint32_t factor, envsh__grid *out, const envsh__allocator *a)
{
    uint32_t x, y, left;
    size_t t = 0, i;
    *out = *g;
    out->width = (g->width + factor - 1) / factor;
    out->height = (g->height + factor - 1) / factor;
    out->count = (size_t)out->width * out->height * g->faces;
    out->memory = (float *)envsh__alloc_array(a, out->count, 5 * sizeof(float));
    if (!out->memory) return 0;
    out->lum = out->memory;
    out->omega = out->lum + out->count;
    out->dx = out->omega + out->count;
    out->dy = out->dx + out->count;
    out->dz = out->dy + out->count;
    memset(out->memory, 0, 5 * out->count * sizeof(float));
    for (y = 0; y < g->height * g->faces; y++) {
        i = envsh__coarse_row(g, out, factor, y);
        for (x = 0, left = factor; x < g->width; x++, t++) {
            out->lum[i] += (float)envsh__weight(g, t);
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
        envsh__v3 d = envsh__v3_normalize(envsh__v3_make(out->dx[i], out->dy[i], out->dz[i]));
        if (out->omega[i] > 0.0f) out->lum[i] /= out->omega[i];
        out->dx[i] = d.x;
        out->dy[i] = d.y;
        out->dz[i] = d.z;
    }
    return 1;
}

/* Maps of more than 2^17 texels are structured by averages, whose size is then about half a degree. */
static envsh_result envsh__structured_build(const envsh__grid *g, uint32_t k, uint32_t *label,
                                            const envsh__allocator *a)
{
    envsh__structured s;
    envsh__grid coarse;
    envsh_result result = ENVSH_ERR_ALLOC;
    uint32_t factor = 1, x, y, left;
    size_t t = 0;
    while (g->count / factor / factor > 131072u) factor++;
    memset(&s, 0, sizeof s);
    if (!envsh__coarsen(g, factor, &coarse, a)) return result;
    s.g = &coarse;
    s.wanted = k;
    s.blocks_wide = (coarse.width + ENVSH__BLOCK - 1) / ENVSH__BLOCK;
    s.blocks_high = (coarse.height + ENVSH__BLOCK - 1) / ENVSH__BLOCK;
    s.block_count = s.blocks_wide * s.blocks_high * coarse.faces;
    s.best = (float *)envsh__alloc_array(a, coarse.count, sizeof *s.best);
    s.label = (uint32_t *)envsh__alloc_array(a, coarse.count, sizeof *s.label);
    s.owner = (uint32_t *)envsh__alloc_array(a, coarse.count, sizeof *s.owner);
    s.queue = (uint32_t *)envsh__alloc_array(a, coarse.count, sizeof *s.queue);
    s.layer = (uint8_t *)envsh__alloc(a, coarse.count);
    s.sample = (uint32_t *)envsh__alloc_array(a, k, sizeof *s.sample);
    s.blocks = (envsh__block *)envsh__alloc_array(a, s.block_count, sizeof *s.blocks);
    if (s.best && s.label && s.owner && s.queue && s.layer && s.sample && s.blocks) {
        envsh__run_structured(&s);
        for (y = 0; y < g->height * g->faces; y++) {
            const uint32_t *row = s.label + envsh__coarse_row(g, &coarse, factor, y);
            for (x = 0, left = factor; x < g->width; x++) {
                label[t++] = *row;
                if (--left) continue;
                left = factor;
                row++;
            }
        }
        result = ENVSH_OK;
    }
    envsh__free(a, s.blocks);
    envsh__free(a, s.sample);
    envsh__free(a, s.layer);
    envsh__free(a, s.queue);
    envsh__free(a, s.owner);
    envsh__free(a, s.label);
    envsh__free(a, s.best);
    envsh__free(a, coarse.memory);
    return result;
}

/* ---- >>regions: median cut, minimum variance and inversion, all by summed-area tables ---- */

typedef struct envsh__moments { double w, x, y, z; } envsh__moments;    /* luminance x solid angle; times direction */

typedef struct envsh__region {
    uint32_t face, x0, y0, x1, y1;
    uint32_t lights;                /* median cut: how many it is to become */
    uint32_t cut_x, cut_y;          /* variance: where it is best cut; both 0: cannot be */
    double   gain, rank;            /* scatter that the cut takes away; regions of high rank are cut first */
    envsh__moments sum;
} envsh__region;

/* (width + 1) x (height + 1) entries a face; entry x, y holds what lies left of and above its corner. */
static void envsh__fill_table(const envsh__grid *g, envsh__moments *table)
{
    uint32_t f, x, y;
    size_t t = 0, stride = (size_t)g->width + 1;
    for (f = 0; f < g->faces; f++, table += stride * ((size_t)g->height + 1)) {
        memset(table, 0, stride * sizeof *table);
        for (y = 0; y < g->height; y++) {
            const envsh__moments *above = table + y * stride;
            envsh__moments *here = table + (y + 1) * stride, row = { 0, 0, 0, 0 };
            here[0] = row;
            for (x = 0; x < g->width; x++, t++) {
                double w = envsh__weight(g, t);
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

/* The same of the energy alone: median cut and inversion ask for no more, and a quarter of the memory is a good part of
   their time. */
static void envsh__fill_energy(const envsh__grid *g, double *table)
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
                row += envsh__weight(g, t);
                here[x + 1] = above[x + 1] + row;
            }
        }
    }
}

static double envsh__energy(const envsh__grid *g, const double *table, const envsh__region *r, uint32_t x0, uint32_t y0,
                            uint32_t x1, uint32_t y1)
{
    size_t stride = (size_t)g->width + 1;
    const double *top = table + stride * ((size_t)g->height + 1) * r->face + y0 * stride;
    const double *bottom = top + (y1 - y0) * stride;
    return (bottom[x1] - top[x1]) - (bottom[x0] - top[x0]);
}

static envsh__moments envsh__area(const envsh__grid *g, const envsh__moments *table, const envsh__region *r,
                                  uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1)
{
    size_t stride = (size_t)g->width + 1;
    const envsh__moments *t = table + stride * ((size_t)g->height + 1) * r->face;
    const envsh__moments *a = t + y0 * stride + x0, *b = t + y0 * stride + x1;
    const envsh__moments *c = t + y1 * stride + x0, *d = t + y1 * stride + x1;
    envsh__moments m;
    m.w = (d->w - b->w) - (c->w - a->w);
    m.x = (d->x - b->x) - (c->x - a->x);
    m.y = (d->y - b->y) - (c->y - a->y);
    m.z = (d->z - b->z) - (c->z - a->z);
    return m;
}

/* Sum of w |d - mean|^2: w - |sum of w d|^2 / w, directions having length 1. */
static double envsh__scatter(const envsh__moments *m)
{
    double s = m->w > 0.0 ? m->w - (m->x * m->x + m->y * m->y + m->z * m->z) / m->w : 0.0;
    return s > 0.0 ? s : 0.0;
}

static void envsh__try_cut(envsh__region *r, const envsh__moments *left, double whole, double least, uint32_t x,
                           uint32_t y)
{
    envsh__moments right;
    double gain;
    right.w = r->sum.w - left->w;
    right.x = r->sum.x - left->x;
    right.y = r->sum.y - left->y;
    right.z = r->sum.z - left->z;
    if (!(left->w > least) || !(right.w > least)) return;         /* no cut may make an empty half */
    gain = whole - envsh__scatter(left) - envsh__scatter(&right);
    if (gain <= r->gain) return;
    r->gain = gain;
    r->cut_x = x;
    r->cut_y = y;
}

/* Viriyothai and Debevec, "Variance minimization light probe sampling", 2009: the cut that leaves the least scatter.
   Which region is cut next is our own choice: the fourth root of w^3 gain is w (gain / w)^(1/4), the importance of
   Agarwal et al. with the cut's gain for the solid angle. By gain alone a sun is never cut; docs/envshadow.md. */
static void envsh__best_cut(const envsh__grid *g, const envsh__moments *table, envsh__region *r)
{
    double whole, least;
    uint32_t i;
    r->sum = envsh__area(g, table, r, r->x0, r->y0, r->x1, r->y1);
    r->gain = -1.0;
    r->cut_x = r->cut_y = 0;
    whole = envsh__scatter(&r->sum);
    least = 1e-12 * r->sum.w;
    for (i = r->x0 + 1; i < r->x1; i++) {
        envsh__moments left = envsh__area(g, table, r, r->x0, r->y0, i, r->y1);
        envsh__try_cut(r, &left, whole, least, i, 0);
    }
    for (i = r->y0 + 1; i < r->y1; i++) {
        envsh__moments left = envsh__area(g, table, r, r->x0, r->y0, r->x1, i);
        envsh__try_cut(r, &left, whole, least, 0, i);
    }
    r->rank = r->cut_x | r->cut_y ? r->gain * r->sum.w * r->sum.w * r->sum.w : -1.0;
}

static void envsh__cut(envsh__region *a, envsh__region *b)
{
    *b = *a;
    if (a->cut_x) a->x1 = b->x0 = a->cut_x;
    else a->y1 = b->y0 = a->cut_y;
}

static uint32_t envsh__run_variance(const envsh__grid *g, const envsh__moments *table, envsh__region *r, uint32_t n,
                                    uint32_t k)
{
    uint32_t i;
    for (i = 0; i < n; i++) envsh__best_cut(g, table, &r[i]);
    while (n < k) {
        uint32_t best = 0;
        for (i = 1; i < n; i++)
            if (r[i].rank > r[best].rank) best = i;
        if (!(r[best].cut_x | r[best].cut_y)) break;
        envsh__cut(&r[best], &r[n]);
        envsh__best_cut(g, table, &r[best]);
        envsh__best_cut(g, table, &r[n++]);
    }
    return n;
}

/* The column (row) in which the energy from the region's left (top) edge passes the target; *nearer is its edge closer
   to the target. */
static uint32_t envsh__locate(const envsh__grid *g, const double *table, const envsh__region *r, int along_x,
                              double target, uint32_t *nearer)
{
    uint32_t lo = along_x ? r->x0 : r->y0, hi = along_x ? r->x1 : r->y1;
    double a = 0.0, b = r->sum.w;
    while (hi - lo > 1) {
        uint32_t mid = lo + (hi - lo) / 2;
        double w = along_x ? envsh__energy(g, table, r, r->x0, r->y0, mid, r->y1)
                           : envsh__energy(g, table, r, r->x0, r->y0, r->x1, mid);
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

/* The line inside the region that comes nearest to the target; the region has two columns (rows) or more. */
static uint32_t envsh__cut_at(const envsh__grid *g, const double *table, const envsh__region *r, int along_x,
                              double target)
{
    uint32_t begin = along_x ? r->x0 : r->y0, end = along_x ? r->x1 : r->y1, line;
    envsh__locate(g, table, r, along_x, target, &line);
    return line <= begin ? begin + 1 : line >= end ? end - 1 : line;
}

/* Lights by energy for each face, at least one where there is any. */
static void envsh__share_faces(const envsh__grid *g, const double *table, envsh__region *r, uint32_t k)
{
    uint32_t f, given = 0, lit = 0;
    double before = 0.0, total = 0.0;
    for (f = 0; f < g->faces; f++) {
        r[f].sum.w = envsh__energy(g, table, &r[f], 0, 0, g->width, g->height);
        lit += r[f].sum.w > 0.0;
        total += r[f].sum.w;
    }
    for (f = 0; f < g->faces; f++) {
        uint32_t until;
        before += r[f].sum.w;
        /* The same additions in the same order: after the last lit face it is k - lit. */
        until = (uint32_t)((double)(k - lit) * (total > 0.0 ? before / total : 0.0) + 0.5);
        r[f].lights = r[f].sum.w > 0.0 ? until - given + 1 : 0;
        given = r[f].sum.w > 0.0 ? until : given;
    }
}

/* Debevec, "A median cut algorithm for light probe sampling", 2005, for any k: a region of n lights is cut across its
   longer side into shares of n / 2 and n - n / 2. */
static uint32_t envsh__run_median(const envsh__grid *g, const double *table, envsh__region *r, uint32_t n,
                                  uint32_t k)
{
    uint32_t i;
    envsh__share_faces(g, table, r, k);
    for (i = 0; i < n;) {
        uint32_t w = r[i].x1 - r[i].x0, h = r[i].y1 - r[i].y0, half = r[i].lights / 2, m;
        double s = 1.0, c, wide, high = h;
        int along_x;
        if (r[i].lights < 2 || (w < 2 && h < 2)) {
            i++;
            continue;
        }
        if (g->faces == 1) envsh__sincos64(ENVSH__PI * (r[i].y0 + 0.5 * h) / g->height, &s, &c);
        wide = g->faces == 1 ? 2.0 * s * w * g->height / g->width : (double)w;
        along_x = h < 2 || (w >= 2 && wide >= high);
        m = envsh__cut_at(g, table, &r[i], along_x, r[i].sum.w * half / r[i].lights);
        r[i].cut_x = along_x ? m : 0;
        r[i].cut_y = along_x ? 0 : m;
        envsh__cut(&r[i], &r[n]);
        r[n].lights = r[i].lights - half;
        r[i].lights = half;
        r[i].sum.w = envsh__energy(g, table, &r[i], r[i].x0, r[i].y0, r[i].x1, r[i].y1);
        r[n].sum.w = envsh__energy(g, table, &r[n], r[n].x0, r[n].y0, r[n].x1, r[n].y1);
        n++;
    }
    return n;
}

/* Cells of equal energy in a strip of rows; chosen: the texel at the centre of each, by inversion. */
static uint32_t envsh__invert_strip(const envsh__grid *g, const double *table, const envsh__region *strip,
                                    uint32_t cells, uint32_t row, envsh__region *r, uint32_t *chosen)
{
    uint32_t j, n = 0, line;
    double part = strip->sum.w / cells;
    if (strip->x1 - strip->x0 < 2) cells = 1;
    for (j = 0; j < cells; j++) {
        uint32_t column = envsh__locate(g, table, strip, 1, part * (j + 0.5), &line);
        r[n] = *strip;
        if (j) r[n].x0 = envsh__cut_at(g, table, strip, 1, part * j);
        if (j + 1 < cells) r[n].x1 = envsh__cut_at(g, table, strip, 1, part * (j + 1.0));
        if (r[n].x0 >= r[n].x1) continue;
        column = column < r[n].x0 ? r[n].x0 : column >= r[n].x1 ? r[n].x1 - 1 : column;
        chosen[n++] = (strip->face * g->height + row) * g->width + column;
    }
    return n;
}

/* Inversion of the cumulative distribution at the centres (i + 0.5) / n of a grid: strips of rows of equal energy,
   each divided into cells of equal energy. Cells that fall into one column (row) become one. */
static uint32_t envsh__run_inversion(const envsh__grid *g, const double *table, envsh__region *r, uint32_t k,
                                     uint32_t *chosen)
{
    envsh__region faces[6], strip;
    uint32_t f, i, n = 0, line;
    memcpy(faces, r, g->faces * sizeof *faces);
    envsh__share_faces(g, table, faces, k);
    for (f = 0; f < g->faces; f++) {
        const envsh__region *all = &faces[f];
        uint32_t lights = all->lights, strips = (uint32_t)(sqrt((double)lights * (g->faces == 1 ? 0.5 : 1.0)) + 0.5);
        double part;
        strips = strips < 1 ? 1 : strips > g->height ? g->height : strips;
        part = all->sum.w / strips;
        if (!lights) {                      /* a black face: its light is dropped, its texels go to the nearest one */
            chosen[n] = 0;
            r[n++] = *all;
            continue;
        }
        for (i = 0; i < strips; i++) {
            uint32_t cells = (uint32_t)((uint64_t)(i + 1) * lights / strips - (uint64_t)i * lights / strips);
            uint32_t row = envsh__locate(g, table, all, 0, part * (i + 0.5), &line);
            strip = *all;
            if (i) strip.y0 = envsh__cut_at(g, table, all, 0, part * i);
            if (i + 1 < strips) strip.y1 = envsh__cut_at(g, table, all, 0, part * (i + 1.0));
            if (strip.y0 >= strip.y1) continue;
            row = row < strip.y0 ? strip.y0 : row >= strip.y1 ? strip.y1 - 1 : row;
            strip.sum.w = envsh__energy(g, table, &strip, 0, strip.y0, strip.x1, strip.y1);
            n += envsh__invert_strip(g, table, &strip, cells, row, r + n, chosen + n);
        }
    }
    return n;
}

/* label: the region of each texel. chosen: the texels that ENVSH_METHOD_CDF picks, else untouched. */
static envsh_result envsh__regions_build(const envsh__grid *g, envsh_method method, uint32_t k, uint32_t *label,
                                         uint32_t *chosen, const envsh__allocator *a)
{
    size_t entries = ((size_t)g->width + 1) * ((size_t)g->height + 1) * g->faces;
    int by_variance = method != ENVSH_METHOD_CDF && method != ENVSH_METHOD_MEDIAN_CUT;
    void *table = envsh__alloc_array(a, entries, by_variance ? sizeof(envsh__moments) : sizeof(double));
    envsh__region *r = table ? (envsh__region *)envsh__alloc_array(a, (size_t)k + 6, sizeof *r) : NULL;
    uint32_t i, n, x, y;

    if (!r) {
        envsh__free(a, table);
        return ENVSH_ERR_ALLOC;
    }
    if (by_variance) envsh__fill_table(g, (envsh__moments *)table);
    else envsh__fill_energy(g, (double *)table);
    memset(r, 0, 6 * sizeof *r);
    for (n = 0; n < g->faces; n++) {
        r[n].face = n;
        r[n].x1 = g->width;
        r[n].y1 = g->height;
    }
    if (by_variance) n = envsh__run_variance(g, (const envsh__moments *)table, r, n, k);
    else if (method == ENVSH_METHOD_CDF) n = envsh__run_inversion(g, (const double *)table, r, k, chosen);
    else n = envsh__run_median(g, (const double *)table, r, n, k);
    for (i = 0; i < n; i++)
        for (y = r[i].y0; y < r[i].y1; y++) {
            uint32_t *row = label + ((size_t)r[i].face * g->height + y) * g->width;
            for (x = r[i].x0; x < r[i].x1; x++) row[x] = i;
        }
    envsh__free(a, r);
    envsh__free(a, table);
    return ENVSH_OK;
}

/* ---- >>lights: from strata to lights ---- */

typedef struct envsh__sums {        /* over a stratum; w is luminance x solid angle, d the direction */
    double rgb[3], omega, w;
    double m[3];                    /* w d */
    double s[6];                    /* w d d^T: xx xy xz yy yz zz */
    double o[3];                    /* omega d of dark texels: where a stratum without energy lies */
    double texels;
} envsh__sums;

/* What an allocator holds, for envsh_stats.peak_bytes: the size stands in front of each block. */
typedef struct envsh__meter { envsh__allocator inner; size_t now, peak; } envsh__meter;

struct envsh_lights {
    envsh__allocator allocator;     /* the caller's, with the meter in between */
    envsh__meter     meter;
    envsh_desc   desc;
    envsh_map    map;               /* its sizes; rgb is not kept */
    uint32_t     roll, count, next_id;
    int          has_sun;           /* light 0 is the sun */
    size_t       lit;               /* lit texels, the sun as one, where they were too few for all lights; else 0 */
    double       slack;             /* unevenness when built: follow acts on twice that; 0 = not known yet */
    envsh_light *list;
    envsh__sums *sums;
    size_t       texels;
    uint32_t    *strata;            /* by texel of the map */
    uint32_t    *order;             /* texels of stratum i: order[start[i] .. start[i + 1]) */
    uint32_t    *start;
    double      *cdf;               /* of stratum i at start[i] + i: running sums of w */
};

/* Everything of the grid into the sums of its labels. A run of one label is summed in a copy, not in memory. */
static void envsh__accumulate(const envsh__grid *g, const uint32_t *label, envsh__sums *sums, uint32_t count)
{
    size_t t;
    float rgb[3];
    envsh__sums s;
    uint32_t column = 0, held = ENVSH_NO_LIGHT;
    memset(sums, 0, count * sizeof *sums);
    memset(&s, 0, sizeof s);
    for (t = 0; t < g->count; t++, column = column + 1 < g->width ? column + 1 : 0) {
        double omega = (double)g->omega[t], w = envsh__weight(g, t), x, y, z;
        if (!(omega > 0.0) || label[t] >= count) continue;
        if (label[t] != held) {
            if (held != ENVSH_NO_LIGHT) sums[held] = s;
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
        envsh__fetch(&g->map, envsh__map_texel(g, t - column, column), rgb);
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
    if (held != ENVSH_NO_LIGHT) sums[held] = s;
}

/* Turns from the grid's azimuths to the map's, exactly as texels lie. */
static envsh__v3 envsh__unroll(const envsh__grid *g, double x, double y, double z)
{
    double s, c;
    if (g->faces == 6) return envsh__v3_make((float)x, (float)y, (float)z);
    envsh__sincos64(2.0 * ENVSH__PI * ((double)g->roll / g->width - 0.5), &s, &c);
    return envsh__v3_make((float)(x * c - z * s), (float)y, (float)(x * s + z * c));
}

/* Half axes of the stratum's radiance seen from its light: twice the standard deviation, as a uniform disc's radius is,
   by the eigenvectors of the 2 x 2 covariance in the tangent plane. A texel's own size is part of it. */
static void envsh__extent(const envsh__sums *s, envsh__v3 d, envsh__v3 *major, envsh__v3 *minor)
{
    envsh__v3 u, v;
    double a = 0.0, b = 0.0, c = 0.0, texel = s->texels > 0.0 ? s->omega / s->texels / 12.0 : 0.0;
    double half, root, along, x = 1.0, y = 0.0, length;
    float p[3], q[3];
    int i, j;
    envsh__v3_basis(d, &u, &v);
    envsh__v3_store(p, u);
    envsh__v3_store(q, v);
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
    *major = envsh__v3_add(envsh__v3_scale(u, (float)x), envsh__v3_scale(v, (float)y));
    *minor = envsh__v3_cross(d, *major);
    *major = envsh__v3_scale(*major, (float)(2.0 * sqrt(along + root)));
    *minor = envsh__v3_scale(*minor, (float)(2.0 * sqrt(along > root ? along - root : 0.0)));
}

/* chosen: the texel whose direction the light takes, or ENVSH_NO_LIGHT: the mean direction. */
static void envsh__make_light(const envsh__grid *g, const envsh__sums *s, uint32_t chosen, envsh_light *light)
{
    double x = s->m[0], y = s->m[1], z = s->m[2], least = 1e-9 * s->w, length;
    envsh__v3 d, major, minor;
    int c;
    if (chosen != ENVSH_NO_LIGHT) {
        x = (double)g->dx[chosen];
        y = (double)g->dy[chosen];
        z = (double)g->dz[chosen];
        least = 0.0;                                    /* of unit length, whatever the energy */
    }
    length = sqrt(x * x + y * y + z * z);
    if (!(length > least)) {                            /* evenly from all round: any direction will do */
        x = z = 0.0;
        y = length = 1.0;
    }
    d = envsh__v3_make((float)(x / length), (float)(y / length), (float)(z / length));
    envsh__extent(s, d, &major, &minor);
    envsh__v3_store(light->direction, envsh__v3_normalize(envsh__unroll(g, (double)d.x, (double)d.y, (double)d.z)));
    envsh__v3_store(light->axis_u, envsh__unroll(g, (double)major.x, (double)major.y, (double)major.z));
    envsh__v3_store(light->axis_v, envsh__unroll(g, (double)minor.x, (double)minor.y, (double)minor.z));
    for (c = 0; c < 3; c++) light->irradiance[c] = (float)s->rgb[c];
    light->solid_angle = (float)s->omega;
}

/* Strata without energy go to the light whose mean direction is nearest; labels and sums become dense. Returns how many
   are left. remap: count entries. */
static uint32_t envsh__drop_dark(const envsh__grid *g, uint32_t *label, envsh__sums *sums, uint32_t *chosen,
                                 uint32_t *remap, uint32_t count)
{
    uint32_t i, j, n = 0;
    size_t t;
    for (i = 0; i < count; i++)
        if (sums[i].w > 0.0) remap[i] = n++;
    if (n == count || n == 0) return n;
    for (i = 0; i < count; i++) {
        double best = 0.0;
        uint32_t nearest = ENVSH_NO_LIGHT;
        for (j = 0; j < count && !(sums[i].w > 0.0); j++) {
            const double *m = sums[j].m, *o = sums[i].o;
            double c = m[0] * o[0] + m[1] * o[1] + m[2] * o[2];
            if (!(sums[j].w > 0.0)) continue;
            c /= sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]) + 1e-300;
            if (nearest != ENVSH_NO_LIGHT && c <= best) continue;
            best = c;
            nearest = remap[j];
        }
        if (!(sums[i].w > 0.0)) remap[i] = nearest;
    }
    for (t = 0; t < g->count; t++)
        if (label[t] < count) label[t] = remap[label[t]];
    for (i = n = 0; i < count; i++)
        if (sums[i].w > 0.0) chosen[n++] = chosen[i];
    envsh__accumulate(g, label, sums, n);
    return n;
}

/* ---- >>sun ---- */

/* The connected spot of at least a tenth of the greatest luminance round the brightest texel, if it is smaller than
   0.03 sr (11 degrees across) and has a light's share of the energy. queue: room for all texels; returns its size. */
static uint32_t envsh__find_sun(const envsh__grid *g, uint32_t k, uint32_t *queue, uint8_t *seen)
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
        energy += envsh__weight(g, t);
        omega += (double)g->omega[t];
        envsh__neighbours(g, (uint32_t)t, next);
        for (i = 0; i < 4; i++)
            if (!seen[next[i]] && g->lum[next[i]] > 0.1f * g->lum[top]) {
                seen[next[i]] = 1;
                queue[tail++] = next[i];
            }
    }
    return head == tail && omega < 0.03 && energy * k >= g->total && k > 1 ? tail : 0;
}

/* Lit texels; with labels, of all but label 0. */
static size_t envsh__count_lit(const envsh__grid *g, const uint32_t *label)
{
    size_t t, lit = 0;
    for (t = 0; t < g->count; t++) lit += g->lum[t] > 0.0f && !(label && label[t] == 0);
    return lit;
}

/* ---- >>strata: what is kept of a map ---- */

static void envsh__sort_strata(envsh_lights *l, const envsh__grid *g, const uint32_t *label)
{
    uint32_t i, x = 0;
    size_t t;
    for (i = 0; i <= l->count; i++) l->start[i] = 0;
    for (t = 0; t < g->count; t++, x = x + 1 < g->width ? x + 1 : 0) {
        uint32_t s = g->omega[t] > 0.0f && l->count ? label[t] : ENVSH_NO_LIGHT;
        l->strata[envsh__map_texel(g, t - x, x)] = s;
        if (s != ENVSH_NO_LIGHT) l->start[s]++;
    }
    for (i = 0, t = 0; i <= l->count; i++) {
        size_t n = l->start[i];
        l->start[i] = (uint32_t)t;
        t += i < l->count ? n : 0;
    }
    for (t = 0; t < g->count; t++)          /* the grid's order within a stratum */
        if (g->omega[t] > 0.0f && l->count) l->order[l->start[label[t]]++] = (uint32_t)t;
    for (i = l->count; i > 0; i--) l->start[i] = l->start[i - 1];
    l->start[0] = 0;
}

/* After the last change: running sums for envsh_lights_jitter. */
static void envsh__fill_cdf(envsh_lights *l, const envsh__grid *g)
{
    uint32_t i, j;
    for (i = 0; i < l->count; i++) {
        double sum = 0.0, *out = l->cdf + l->start[i] + i;
        for (j = l->start[i]; j < l->start[i + 1]; j++) {
            *out++ = sum;
            sum += envsh__weight(g, l->order[j]);
        }
        *out = sum;
    }
}

static void envsh__fill_lights(envsh_lights *l, const envsh__grid *g, const uint32_t *chosen)
{
    uint32_t i;
    for (i = 0; i < l->count; i++) {
        /* A stratum that a video has made black keeps the direction that it had. */
        if (l->sums[i].w > 0.0) {
            envsh__make_light(g, &l->sums[i], chosen ? chosen[i] : ENVSH_NO_LIGHT, &l->list[i]);
        } else {
            l->list[i].irradiance[0] = l->list[i].irradiance[1] = l->list[i].irradiance[2] = 0.0f;
            l->list[i].solid_angle = (float)l->sums[i].omega;
        }
        l->list[i].flags = l->has_sun && i == 0 ? ENVSH_LIGHT_SUN : 0;
    }
}

/* list, sums and start for k lights more or less than there are. */
static int envsh__reserve(envsh_lights *l, uint32_t k)
{
    const envsh__allocator *a = &l->allocator;
    envsh_light *list = (envsh_light *)envsh__alloc_array(a, (size_t)k + 1, sizeof *list);
    envsh__sums *sums = (envsh__sums *)envsh__alloc_array(a, (size_t)k + 1, sizeof *sums);
    uint32_t *start = (uint32_t *)envsh__alloc_array(a, (size_t)k + 2, sizeof *start);
    double *cdf = (double *)envsh__alloc_array(a, l->texels + k + 1, sizeof *cdf);
    if (!list || !sums || !start || !cdf) {
        envsh__free(a, cdf);
        envsh__free(a, start);
        envsh__free(a, sums);
        envsh__free(a, list);
        return 0;
    }
    memset(list, 0, ((size_t)k + 1) * sizeof *list);
    if (l->list) {
        memcpy(list, l->list, l->count * sizeof *list);
        memcpy(sums, l->sums, l->count * sizeof *sums);
        memcpy(start, l->start, ((size_t)l->count + 1) * sizeof *start);
    }
    envsh__free(a, l->cdf);
    envsh__free(a, l->start);
    envsh__free(a, l->sums);
    envsh__free(a, l->list);
    l->list = list;
    l->sums = sums;
    l->start = start;
    l->cdf = cdf;
    return 1;
}

/* ---- >>build ---- */

static envsh_result envsh__label(const envsh__grid *g, envsh_method method, uint32_t k, uint32_t *label,
                                 uint32_t *chosen, const envsh__allocator *a)
{
    if (method == ENVSH_METHOD_STRUCTURED || (g->faces == 6 && k < 6))
        return envsh__structured_build(g, k, label, a);
    return envsh__regions_build(g, method, k, label, chosen, a);
}

/* The method on what is left beside the sun; both end up in the labels. */
static envsh_result envsh__label_with_sun(envsh_lights *l, const envsh__grid *g, uint32_t *label, uint32_t *chosen,
                                          uint32_t *labels)
{
    const envsh__allocator *a = &l->allocator;
    uint32_t k = l->desc.light_count, size = 0, i;
    uint32_t *queue = NULL;
    uint8_t *seen = NULL;
    float *kept = NULL;
    envsh_result result;
    size_t t;
    if (l->desc.split_sun) {
        queue = (uint32_t *)envsh__alloc_array(a, g->count, sizeof *queue);
        seen = queue ? (uint8_t *)envsh__alloc(a, g->count) : NULL;
        size = seen ? envsh__find_sun(g, k, queue, seen) : 0;
        kept = size ? (float *)envsh__alloc_array(a, size, sizeof *kept) : NULL;
    }
    if (l->desc.split_sun && (!seen || (size && !kept))) {
        result = ENVSH_ERR_ALLOC;
    } else {
        envsh__grid rest = *g;
        for (i = 0; i < size; i++) {
            kept[i] = g->lum[queue[i]];
            g->lum[queue[i]] = 0.0f;
        }
        /* Summed anew: beside a sun of 1e16 times the sky, a difference would be rounding, of either sign. */
        if (size) rest.total = envsh__total(g);
        result = envsh__label(&rest, l->desc.method, size ? k - 1 : k, label, chosen + (size != 0), a);
        for (t = 0; size && t < g->count; t++) label[t] += label[t] != ENVSH_NO_LIGHT;
        for (i = 0; i < size; i++) {
            g->lum[queue[i]] = kept[i];
            label[queue[i]] = 0;
        }
        if (size) chosen[0] = ENVSH_NO_LIGHT;
        l->has_sun = size != 0;
        *labels = k + 6;
    }
    envsh__free(a, kept);
    envsh__free(a, seen);
    envsh__free(a, queue);
    return result;
}

/* The labels lie where the running sums will be at the end: fresh memory costs as much time as what is done with it. */
static envsh_result envsh__build_lights(envsh_lights *l, const envsh__grid *g)
{
    const envsh__allocator *a = &l->allocator;
    uint32_t k = l->desc.light_count, labels = 0, i, *label = (uint32_t *)(void *)l->cdf;
    uint32_t *chosen = (uint32_t *)envsh__alloc_array(a, (size_t)k + 7, 2 * sizeof *chosen);
    envsh__sums *sums = chosen ? (envsh__sums *)envsh__alloc_array(a, (size_t)k + 7, sizeof *sums) : NULL;
    envsh_result result = ENVSH_ERR_ALLOC;
    size_t t;
    if (sums) {
        for (i = 0; i < k + 7; i++) chosen[i] = ENVSH_NO_LIGHT;
        for (t = 0; t < g->count; t++) label[t] = ENVSH_NO_LIGHT;
        result = g->total > 0.0 ? envsh__label_with_sun(l, g, label, chosen, &labels) : ENVSH_OK;
    }
    if (result == ENVSH_OK) {
        envsh__accumulate(g, label, sums, labels);
        l->count = envsh__drop_dark(g, label, sums, chosen, chosen + k + 7, labels);
        if (l->desc.method != ENVSH_METHOD_CDF)
            for (i = 0; i < l->count; i++) chosen[i] = ENVSH_NO_LIGHT;
        memcpy(l->sums, sums, l->count * sizeof *sums);
        l->lit = l->count < k ? envsh__count_lit(g, l->has_sun ? label : NULL) + (l->has_sun ? 1 : 0) : 0;
        if (l->lit > k) l->lit = 0;         /* the method's rounding, not the map */
        envsh__sort_strata(l, g, label);
        envsh__fill_lights(l, g, chosen);
        envsh__fill_cdf(l, g);
        for (i = 0; i < l->count; i++) l->list[i].id = l->next_id++;
    }
    envsh__free(a, sums);
    envsh__free(a, chosen);
    return result;
}

static void *envsh__meter_alloc(size_t size, void *user)
{
    envsh__meter *m = (envsh__meter *)user;
    char *block = size <= SIZE_MAX - 16 ? (char *)envsh__alloc(&m->inner, size + 16) : NULL;
    if (!block) return NULL;
    memcpy(block, &size, sizeof size);
    m->now += size + 16;
    if (m->now > m->peak) m->peak = m->now;
    return block + 16;
}

static void envsh__meter_free(void *memory, void *user)
{
    envsh__meter *m = (envsh__meter *)user;
    char *block = (char *)memory - 16;
    size_t size;
    memcpy(&size, block, sizeof size);
    m->now -= size + 16;
    envsh__free(&m->inner, block);
}

static void envsh__fill_stats(const envsh_lights *l, const envsh__grid *g, envsh_stats *stats)
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

static envsh_result envsh__check_desc(const envsh_desc *d)
{
    if (d->light_count > ENVSH_MAX_LIGHTS || (unsigned)d->method >= ENVSH_METHOD_COUNT) return ENVSH_ERR_DESC;
    return envsh__allocator_valid(d->allocator.alloc_fn, d->allocator.free_fn) ? ENVSH_OK : ENVSH_ERR_DESC;
}

ENVSH_DEF envsh_result envsh_lights_build(const envsh_desc *desc, const envsh_map *map, envsh_lights **out,
                                          envsh_stats *stats)
{
    envsh__allocator inner;
    envsh__grid grid;
    envsh_desc d;
    envsh_lights *l;
    envsh_result result;
    size_t texels = 0;

    memset(&d, 0, sizeof d);
    memset(&grid, 0, sizeof grid);
    if (desc) d = *desc;
    if (!map || !out) return ENVSH_ERR_ARGUMENT;
    result = envsh__check_desc(&d);
    if (result == ENVSH_OK) result = envsh__check_map(map, &texels);
    if (result != ENVSH_OK) return result;
    if (!d.light_count) d.light_count = 128;
    if (d.method == ENVSH_METHOD_DEFAULT) d.method = ENVSH_METHOD_VARIANCE;
    inner = envsh__allocator_make(d.allocator.alloc_fn, d.allocator.free_fn, d.allocator.user);
    l = (envsh_lights *)envsh__alloc(&inner, sizeof *l);
    if (!l) return ENVSH_ERR_ALLOC;
    memset(l, 0, sizeof *l);
    l->meter.inner = inner;
    l->meter.now = l->meter.peak = sizeof *l;
    l->allocator = envsh__allocator_make(envsh__meter_alloc, envsh__meter_free, &l->meter);
    l->desc = d;
    l->map = *map;
    l->map.rgb = NULL;
    l->texels = texels;
    result = envsh__grid_make(&grid, map, d.hemisphere, ENVSH_NO_LIGHT, &l->allocator);
    l->roll = grid.roll;
    l->strata = (uint32_t *)envsh__alloc_array(&l->allocator, texels, sizeof *l->strata);
    l->order = (uint32_t *)envsh__alloc_array(&l->allocator, texels, sizeof *l->order);
    if (result == ENVSH_OK && (!l->strata || !l->order || !envsh__reserve(l, d.light_count + 6)))
        result = ENVSH_ERR_ALLOC;
    if (result == ENVSH_OK) result = envsh__build_lights(l, &grid);
    envsh__free(&l->allocator, grid.memory);
    if (result != ENVSH_OK) {
        envsh_lights_free(l);
        return result;
    }
    if (stats) envsh__fill_stats(l, &grid, stats);
    *out = l;
    return ENVSH_OK;
}

ENVSH_DEF void envsh_lights_free(envsh_lights *l)
{
    envsh__allocator inner;
    if (!l) return;
    inner = l->meter.inner;
    envsh__free(&l->allocator, l->cdf);
    envsh__free(&l->allocator, l->start);
    envsh__free(&l->allocator, l->sums);
    envsh__free(&l->allocator, l->list);
    envsh__free(&l->allocator, l->order);
    envsh__free(&l->allocator, l->strata);
    envsh__free(&inner, l);
}

ENVSH_DEF const envsh_light *envsh_lights_get(const envsh_lights *lights, uint32_t *count)
{
    if (count) *count = lights ? lights->count : 0;
    return lights ? lights->list : NULL;
}

ENVSH_DEF const uint32_t *envsh_lights_strata(const envsh_lights *lights, size_t *count)
{
    if (count) *count = lights ? lights->texels : 0;
    return lights ? lights->strata : NULL;
}

ENVSH_DEF const char *envsh_result_text(envsh_result result)
{
    static const char *const texts[] = {
#define ENVSH__TEXT(name, text) text,
        ENVSH_RESULTS(ENVSH__TEXT)
#undef ENVSH__TEXT
    };
    return (unsigned)result < ENVSH_RESULT_COUNT ? texts[result] : "unknown result";
}

ENVSH_DEF double envsh_texel_solid_angle(envsh_projection projection, uint32_t width, uint32_t height, uint32_t x,
                                         uint32_t y)
{
    envsh_map map;
    memset(&map, 0, sizeof map);
    map.projection = projection;
    map.width = width;
    map.height = height;
    return x < width && y < height ? envsh__solid_angle(&map, 0, x, y, 0) : 0.0;
}

static double envsh__hold_near(float x, uint32_t size)
{
    double most = 8.0 * size, d = envsh__finite(x) ? (double)x : 0.0;
    return d > most ? most : d < -most ? -most : d;
}

ENVSH_DEF void envsh_texel_direction(envsh_projection projection, uint32_t width, uint32_t height, uint32_t face,
                                     float x, float y, float direction[3])
{
    envsh_map map;
    double d[3];
    int i;
    memset(&map, 0, sizeof map);
    map.projection = projection;
    map.width = width ? width : 1;
    map.height = height ? height : 1;
    envsh__direction(&map, face, envsh__hold_near(x, map.width), envsh__hold_near(y, map.height), d);
    for (i = 0; i < 3; i++) direction[i] = (float)d[i];
}

/* ---- >>jitter ---- */

ENVSH_DEF envsh_result envsh_lights_jitter(const envsh_lights *l, uint32_t frame, uint32_t seed, envsh_light *out)
{
    uint32_t i;
    if (!l || (!out && l->count)) return ENVSH_ERR_ARGUMENT;
    for (i = 0; i < l->count; i++) {
        uint32_t hash = envsh__hash_combine(seed, l->list[i].id), t, row, column;
        uint32_t first = l->start[i], a, b;
        envsh__cdf cdf;
        envsh__cdf_sample s;
        double d[3], length;
        out[i] = l->list[i];
        if (first == l->start[i + 1]) continue;         /* the sun has taken all of its texels */
        /* The R2 sequence, shifted for each light: which texel, and how high in it; how far across is what is left. */
        a = 0x80000000u + frame * 3242174889u + hash;
        b = 0x80000000u + frame * 2447445413u + envsh__hash32(hash);
        cdf.sums = l->cdf + first + i;
        cdf.count = l->start[i + 1] - first;
        s = envsh__cdf_sample_at(&cdf, envsh__to_unit(a));
        t = l->order[first + s.index];
        row = t / l->map.width;
        column = (uint32_t)(((uint64_t)t % l->map.width + l->roll) % l->map.width);
        envsh__direction(&l->map, row / l->map.height, (double)column + (double)s.fraction,
                         (double)(row % l->map.height) + (double)envsh__to_unit(b), d);
        length = 1.0 / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        for (row = 0; row < 3; row++) out[i].direction[row] = (float)(d[row] * length);
    }
    return ENVSH_OK;
}

/* ---- >>follow: the next map, or another k, with strata that stay ---- */

typedef struct envsh__follow {
    envsh_lights      *l;
    const envsh__grid *g;
    uint32_t *label;                /* by texel of the grid */
    uint32_t *partner;              /* the stratum that i would merge with */
    double   *cost, *gain;          /* importance that merging adds; that splitting takes away */
    uint8_t  *touched, *seen;
    uint32_t *queue;                /* this and seen: of the search for the sun; NULL without split_sun */
    envsh_light *before;
    uint32_t  changed;
} envsh__follow;

/* The greatest eigenvalue of a stratum's scatter, and its direction, by powers of the matrix. */
static double envsh__main_axis(const envsh__sums *s, envsh__v3 *axis)
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
    *axis = envsh__v3_make((float)v[0], (float)v[1], (float)v[2]);
    return length;
}

/* Where a stratum is cut: through its mean, across its main axis. */
typedef struct envsh__plane { envsh__v3 axis; double mean; } envsh__plane;

static envsh__plane envsh__plane_across(const envsh__sums *s)
{
    envsh__plane p;
    envsh__main_axis(s, &p.axis);
    p.mean = (s->m[0] * (double)p.axis.x + s->m[1] * (double)p.axis.y + s->m[2] * (double)p.axis.z) / s->w;
    return p;
}

static int envsh__beyond(const envsh__grid *g, const envsh__plane *p, uint32_t t)
{
    return (double)(g->dx[t] * p->axis.x) + (double)(g->dy[t] * p->axis.y) + (double)(g->dz[t] * p->axis.z) > p->mean;
}

/* Whether both sides of the cut have energy: the scatter of one lit texel, too, is rounding and not always zero. */
static int envsh__divisible(const envsh__follow *f, uint32_t which)
{
    envsh__plane p = envsh__plane_across(&f->l->sums[which]);
    uint32_t j, sides = 0;
    for (j = f->l->start[which]; j < f->l->start[which + 1] && sides != 3; j++)
        if (f->g->lum[f->l->order[j]] > 0.0f) sides |= envsh__beyond(f->g, &p, f->l->order[j]) ? 2u : 1u;
    return sides == 3;
}

/* Energy times the fourth root of the scatter per energy: the importance of envsh__best_cut. */
static double envsh__rank(double w, double scatter) { return sqrt(sqrt(w * w * w * scatter)); }

/* What cutting each stratum takes away and what merging it with its best partner adds, by Ward's criterion, as
   importance. The sun keeps to itself. */
static void envsh__rate(envsh__follow *f)
{
    const envsh_lights *l = f->l;
    uint32_t i, j, first = l->has_sun ? 1 : 0;
    envsh__v3 axis;
    for (i = 0; i < l->count; i++) {
        const envsh__sums *a = &l->sums[i];
        f->touched[i] = i < first;
        f->cost[i] = 1e300;
        f->partner[i] = i;
        /* Cutting an even spread in two leaves a quarter of the scatter along the axis. */
        f->gain[i] = a->texels > 1.5 && a->w > 0.0 && i >= first && envsh__divisible(f, i)
                   ? 0.75 * envsh__main_axis(a, &axis) : 0.0;
        f->gain[i] = envsh__rank(a->w, f->gain[i]);
        for (j = first; j < l->count && i >= first; j++) {
            const envsh__sums *b = &l->sums[j];
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
                ward = envsh__rank(a->w + b->w, a->w * b->w / (a->w + b->w) * (dx * dx + dy * dy + dz * dz));
            }
            if (ward < f->cost[i]) {
                f->cost[i] = ward;
                f->partner[i] = j;
            }
        }
    }
}

static uint32_t envsh__pick_split(const envsh__follow *f)
{
    uint32_t i, best = ENVSH_NO_LIGHT;
    for (i = 0; i < f->l->count; i++)
        if (!f->touched[i] && f->gain[i] > 0.0 && (best == ENVSH_NO_LIGHT || f->gain[i] > f->gain[best])) best = i;
    return best;
}

static uint32_t envsh__pick_merge(const envsh__follow *f)
{
    uint32_t i, best = ENVSH_NO_LIGHT;
    for (i = 0; i < f->l->count; i++)
        if (!f->touched[i] && f->partner[i] != i && !f->touched[f->partner[i]] &&
            (best == ENVSH_NO_LIGHT || f->cost[i] < f->cost[best])) best = i;
    return best;
}

/* The texels of a stratum beyond its mean along its main axis become stratum `other`. */
static void envsh__split(envsh__follow *f, uint32_t which, uint32_t other)
{
    envsh__plane p = envsh__plane_across(&f->l->sums[which]);
    uint32_t j;
    for (j = f->l->start[which]; j < f->l->start[which + 1]; j++)
        if (envsh__beyond(f->g, &p, f->l->order[j])) f->label[f->l->order[j]] = other;
    f->touched[which] = 1;
}

/* The fainter of the pair gives its texels up; its number is free then. */
static uint32_t envsh__merge(envsh__follow *f, uint32_t a)
{
    envsh_lights *l = f->l;
    uint32_t b = f->partner[a], keep = l->sums[a].w >= l->sums[b].w ? a : b, gone = keep == a ? b : a, j;
    for (j = l->start[gone]; j < l->start[gone + 1]; j++) f->label[l->order[j]] = keep;
    f->touched[a] = f->touched[b] = 1;
    return gone;
}

/* The lights in slots of `count`; label `from` becomes `to`. */
static void envsh__move_label(envsh__follow *f, uint32_t from, uint32_t to)
{
    envsh_lights *l = f->l;
    size_t t;
    for (t = 0; t < f->g->count; t++)
        if (f->label[t] == from) f->label[t] = to;
    l->list[to] = l->list[from];
}

static void envsh__resum(envsh__follow *f)
{
    envsh__accumulate(f->g, f->label, f->l->sums, f->l->count);
    envsh__sort_strata(f->l, f->g, f->label);
}

/* One round of splits or merges of strata that no earlier one of the round changed. 0: nothing left to do. */
static int envsh__change_count(envsh__follow *f, uint32_t k)
{
    envsh_lights *l = f->l;
    uint32_t which, n = l->count, gone_count = 0, i;
    if (n == k) return 0;
    envsh__rate(f);
    if (n < k) {
        while (n < k && (which = envsh__pick_split(f)) != ENVSH_NO_LIGHT) {
            envsh__split(f, which, n);
            l->list[n++].id = l->next_id++;
            f->changed++;
        }
        if (n == l->count) return 0;
        l->count = n;
    } else {
        while (n - gone_count > k && (which = envsh__pick_merge(f)) != ENVSH_NO_LIGHT) {
            l->sums[envsh__merge(f, which)].texels = -1.0;
            gone_count++;
        }
        if (!gone_count) return 0;
        for (i = 0; i < n; i++) {           /* the last light takes the empty place */
            while (n > i && l->sums[n - 1].texels < 0.0) n--;
            if (i >= n || !(l->sums[i].texels < 0.0)) continue;
            envsh__move_label(f, n - 1, i);
            n--;
        }
        l->count = n;
    }
    envsh__resum(f);
    return 1;
}

/* Splits that gain more than `ratio` times what the cheapest merge costs. */
static void envsh__rebalance(envsh__follow *f, double ratio)
{
    uint32_t split, merge, fresh = f->l->count / 8, done = 0, i;
    envsh__rate(f);
    for (i = 0; i < f->l->count; i++) {     /* the sun has taken all texels of these: they are free for others */
        if (f->l->start[i] < f->l->start[i + 1]) continue;
        f->touched[i] = 1;
        split = envsh__pick_split(f);
        if (split == ENVSH_NO_LIGHT) break;
        envsh__split(f, split, i);
        f->l->list[i].id = f->l->next_id++;
        f->changed++;
        done = 1;
    }
    for (; fresh > 0; fresh--) {
        split = envsh__pick_split(f);
        if (split == ENVSH_NO_LIGHT) break;
        f->touched[split] = 1;              /* it must not be one of the pair */
        merge = envsh__pick_merge(f);
        if (merge == ENVSH_NO_LIGHT || !(f->gain[split] > ratio * f->cost[merge])) break;
        merge = envsh__merge(f, merge);
        envsh__split(f, split, merge);
        f->l->list[merge].id = f->l->next_id++;
        f->changed++;
        done = 1;
    }
    if (done) envsh__resum(f);
}

static double envsh__unevenness(envsh__follow *f)
{
    uint32_t split, merge;
    envsh__rate(f);
    split = envsh__pick_split(f);
    if (split == ENVSH_NO_LIGHT) return 1.0;
    f->touched[split] = 1;
    merge = envsh__pick_merge(f);
    if (merge == ENVSH_NO_LIGHT || !(f->gain[split] > f->cost[merge])) return 1.0;
    return f->cost[merge] > 1e-6 * f->gain[split] ? f->gain[split] / f->cost[merge] : 1e6;
}

/* What the sun's stratum leaves falls to the nearest other light. */
static void envsh__leave_sun(envsh__follow *f)
{
    envsh_lights *l = f->l;
    const envsh__grid *g = f->g;
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

/* The sun's stratum goes where the sun is now, and stays where it was while there is none. One that comes up becomes
   light 0; what was light 0 is the last one then. */
static void envsh__follow_sun(envsh__follow *f)
{
    envsh_lights *l = f->l;
    uint32_t k = l->desc.light_count, size = envsh__find_sun(f->g, k, f->queue, f->seen), i;
    if (k < 2) l->has_sun = 0;
    if (!size || (l->has_sun && l->count < 2)) return;
    if (l->has_sun) {
        envsh__leave_sun(f);
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

static void envsh__run_follow(envsh__follow *f, uint32_t k)
{
    envsh_lights *l = f->l;
    uint32_t x = 0;
    size_t t;
    if (!(l->slack > 0.0)) l->slack = envsh__unevenness(f);
    for (t = 0; t < f->g->count; t++, x = x + 1 < f->g->width ? x + 1 : 0)
        f->label[t] = l->strata[envsh__map_texel(f->g, t - x, x)];
    if (l->desc.split_sun) envsh__follow_sun(f);
    envsh__resum(f);
    while (envsh__change_count(f, k)) {}
    envsh__rebalance(f, 2.0 * l->slack);
}

/* Angles between lights of equal id, by energy. */
static void envsh__measure_moves(const envsh_lights *l, const envsh_light *before, uint32_t count, envsh_stats *stats)
{
    uint32_t i, j;
    double sum = 0.0, weight = 0.0;
    for (i = 0; i < l->count; i++) {
        const envsh_light *a = &l->list[i];
        float angle;
        double w = (double)envsh__luminance(a->irradiance);
        for (j = 0; j < count && before[j].id != a->id; j++) {}
        if (j == count) continue;
        angle = 2.0f * envsh__asin(0.5f * envsh__v3_length(envsh__v3_sub(envsh__v3_load(a->direction),
                                                                       envsh__v3_load(before[j].direction))));
        if (angle > stats->largest_move) stats->largest_move = angle;
        sum += w * (double)angle;
        weight += w;
    }
    stats->mean_move = weight > 0.0 ? (float)(sum / weight) : 0.0f;
}

/* A map that was black when built, or k that must come from nothing, is built anew in place. */
static envsh_result envsh__rebuild(envsh_lights *l, const envsh_map *map, uint32_t k, envsh_stats *stats)
{
    envsh_lights *fresh, kept;
    envsh_desc d = l->desc;
    envsh_stats s;
    envsh_result result;
    uint32_t i;
    d.light_count = k;
    result = envsh_lights_build(&d, map, &fresh, &s);
    if (result != ENVSH_OK) return result;
    kept = *l;
    *l = *fresh;
    *fresh = kept;
    l->allocator.user = &l->meter;
    fresh->allocator.user = &fresh->meter;
    for (i = 0; i < l->count; i++) l->list[i].id = kept.next_id + i;
    l->next_id = kept.next_id + l->count;
    envsh_lights_free(fresh);
    s.changed = l->count;
    s.peak_bytes += kept.meter.now;         /* both are there at once */
    if (stats) *stats = s;
    return ENVSH_OK;
}

/* What a follow needs beside the grid, room for `most` lights included. 0: no memory; envsh__follow_close then too. */
static int envsh__follow_open(envsh__follow *f, size_t texels, uint32_t most)
{
    const envsh_lights *l = f->l;
    const envsh__allocator *a = &l->allocator;
    f->label = (uint32_t *)envsh__alloc_array(a, texels, sizeof *f->label);
    f->partner = (uint32_t *)envsh__alloc_array(a, most, sizeof *f->partner);
    f->cost = (double *)envsh__alloc_array(a, most, sizeof *f->cost);
    f->gain = (double *)envsh__alloc_array(a, most, sizeof *f->gain);
    f->touched = (uint8_t *)envsh__alloc(a, most);
    f->before = (envsh_light *)envsh__alloc_array(a, l->count, sizeof *f->before);
    if (l->desc.split_sun) {
        f->queue = (uint32_t *)envsh__alloc_array(a, texels, sizeof *f->queue);
        f->seen = (uint8_t *)envsh__alloc(a, texels);
    }
    if (!f->label || !f->partner || !f->cost || !f->gain || !f->touched || !f->before) return 0;
    return !l->desc.split_sun || (f->queue && f->seen);
}

static void envsh__follow_close(envsh__follow *f)
{
    const envsh__allocator *a = &f->l->allocator;
    envsh__free(a, f->seen);
    envsh__free(a, f->queue);
    envsh__free(a, f->before);
    envsh__free(a, f->touched);
    envsh__free(a, f->gain);
    envsh__free(a, f->cost);
    envsh__free(a, f->partner);
    envsh__free(a, f->label);
}

/* Lights that a nearly black map was too few texels for, and this one is not. */
static int envsh__is_fed(const envsh__follow *f, uint32_t k)
{
    const envsh_lights *l = f->l;
    size_t lit;
    uint32_t sun;
    if (!l->lit || k <= l->count) return 0;
    lit = envsh__count_lit(f->g, NULL);
    sun = l->desc.split_sun ? envsh__find_sun(f->g, k, f->queue, f->seen) : 0;
    return lit - sun + (sun ? 1 : 0) > l->lit;
}

ENVSH_DEF envsh_result envsh_lights_follow(envsh_lights *l, const envsh_map *map, uint32_t light_count,
                                           envsh_stats *stats)
{
    envsh__follow f;
    envsh__grid g;
    uint32_t k, asked, old, most;
    envsh_result result;
    size_t texels;
    int anew;

    if (!l || !map || light_count > ENVSH_MAX_LIGHTS) return ENVSH_ERR_ARGUMENT;
    result = envsh__check_map(map, &texels);
    if (result != ENVSH_OK) return result;
    if ((map->projection == ENVSH_MAP_CUBE) != (l->map.projection == ENVSH_MAP_CUBE) || map->width != l->map.width ||
        map->height != l->map.height) return ENVSH_ERR_ARGUMENT;
    k = light_count ? light_count : l->count;
    asked = light_count || (l->count && !l->lit) ? k : l->desc.light_count;
    if (!l->count) return envsh__rebuild(l, map, asked, stats);
    memset(&f, 0, sizeof f);
    memset(&g, 0, sizeof g);
    old = l->count;
    most = (k > old ? k : old) + 1;
    l->meter.peak = l->meter.now;
    f.l = l;
    f.g = &g;
    result = envsh__grid_make(&g, map, l->desc.hemisphere, l->roll, &l->allocator);
    if (!envsh__follow_open(&f, texels, most)) result = ENVSH_ERR_ALLOC;
    anew = result == ENVSH_OK && envsh__is_fed(&f, asked);
    if (result == ENVSH_OK && !anew && !envsh__reserve(l, most)) result = ENVSH_ERR_ALLOC;
    if (result == ENVSH_OK && !anew) {
        memcpy(f.before, l->list, old * sizeof *f.before);
        l->desc.light_count = asked;
        envsh__run_follow(&f, k);
        envsh__fill_lights(l, &g, NULL);
        envsh__fill_cdf(l, &g);
        if (stats) {
            envsh__fill_stats(l, &g, stats);
            stats->changed = f.changed;
            envsh__measure_moves(l, f.before, old, stats);
        }
    }
    envsh__follow_close(&f);
    envsh__free(&l->allocator, g.memory);
    return anew ? envsh__rebuild(l, map, asked, stats) : result;
}

static void envsh__swap(envsh_light *lights, uint32_t a, uint32_t b)
{
    envsh_light moved = lights[a];
    lights[a] = lights[b];
    lights[b] = moved;
}

/* The brightest light of those that come after the last one found, in order of luminance and then of place. Begins
   with *bright infinite. */
static uint32_t envsh__next_brightest(const envsh_light *list, uint32_t count, float *bright, uint32_t last)
{
    uint32_t i, best = ENVSH_NO_LIGHT;
    float most = 0.0f;
    for (i = 0; i < count; i++) {
        float w = envsh__luminance(list[i].irradiance);
        w = w > 0.0f ? w : 0.0f;                    /* NaN too */
        if (w > *bright || (!(w < *bright) && last != ENVSH_NO_LIGHT && i <= last)) continue;
        if (best != ENVSH_NO_LIGHT && w <= most) continue;
        most = w;
        best = i;
    }
    *bright = most;
    return best;
}

ENVSH_DEF envsh_result envsh_match(const envsh_light *previous, uint32_t previous_count, envsh_light *lights,
                                   uint32_t count)
{
    uint32_t i, j, next = 0, kept = previous_count < count ? previous_count : count, which = ENVSH_NO_LIGHT;
    float bright = envsh__from_bits(0x7f800000u);
    if ((!previous && previous_count) || (!lights && count)) return ENVSH_ERR_ARGUMENT;
    for (i = 0; i < previous_count; i++)
        if (previous[i].id >= next) next = previous[i].id + 1;
    for (i = 0; i < kept; i++) {            /* partners come first, with the previous light's place for an id */
        uint32_t best = i;
        float most = -2.0f;
        which = envsh__next_brightest(previous, previous_count, &bright, which);
        for (j = i; j < count; j++) {
            float c = envsh__v3_dot(envsh__v3_load(previous[which].direction), envsh__v3_load(lights[j].direction));
            if (c > most) {
                most = c;
                best = j;
            }
        }
        envsh__swap(lights, i, best);
        lights[i].id = which;
    }
    for (i = 0; i < kept; i++) {            /* to their places; where nobody has one, the first whose place is gone */
        uint32_t best = ENVSH_NO_LIGHT;
        for (j = i; j < kept && (best == ENVSH_NO_LIGHT || lights[best].id != i); j++)
            if (lights[j].id == i || (lights[j].id >= kept && (best == ENVSH_NO_LIGHT ||
                                                               lights[j].id < lights[best].id))) best = j;
        envsh__swap(lights, i, best);
    }
    for (i = 0; i < kept; i++) lights[i].id = previous[lights[i].id].id;
    for (; i < count; i++) lights[i].id = next++;
    return ENVSH_OK;
}

ENVSH_DEF envsh_result envsh_rotate(envsh_light *lights, uint32_t count, const float rotation[16])
{
    float scale;
    uint32_t i;
    if ((!lights && count) || !rotation || !envsh__m4_is_rigid_uniform(rotation, &scale)) return ENVSH_ERR_ARGUMENT;
    if (!(fabsf(scale - 1.0f) < 1e-3f)) return ENVSH_ERR_ARGUMENT;
    scale = 1.0f / scale;
    for (i = 0; i < count; i++) {
        envsh_light *l = &lights[i];
        envsh__v3_store(l->direction,
                        envsh__v3_normalize(envsh__m4_direction(rotation, envsh__v3_load(l->direction))));
        envsh__v3_store(l->axis_u,
                        envsh__v3_scale(envsh__m4_direction(rotation, envsh__v3_load(l->axis_u)), scale));
        envsh__v3_store(l->axis_v,
                        envsh__v3_scale(envsh__m4_direction(rotation, envsh__v3_load(l->axis_v)), scale));
    }
    return ENVSH_OK;
}

/* ---- >>gltf: text without the C library, whose numbers depend on the locale ---- */

typedef struct envsh__text { char *out; size_t size, length; } envsh__text;

static void envsh__put(envsh__text *t, const char *s)
{
    for (; *s; s++, t->length++)
        if (t->length + 1 < t->size) t->out[t->length] = *s;
}

static void envsh__put_unsigned(envsh__text *t, uint32_t v)
{
    char digits[11];
    int n = 10;
    digits[n] = 0;
    do {
        digits[--n] = (char)('0' + v % 10u);
        v /= 10u;
    } while (v);
    envsh__put(t, digits + n);
}

/* Nine significant digits: every float comes back the same. JSON has no infinity: what is not finite is 0. */
static void envsh__put_float(envsh__text *t, float f)
{
    double v = (double)f;
    int exponent = 0;
    char one[2] = { 0, 0 };
    uint32_t digits, scale;
    if (v < 0.0 && envsh__finite(f)) {
        envsh__put(t, "-");
        v = -v;
    }
    if (!(v > 0.0) || !envsh__finite(f)) {
        envsh__put(t, "0");
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
        envsh__put(t, one);
        if (scale == 100000000u) envsh__put(t, ".");
    }
    envsh__put(t, exponent < 0 ? "e-" : "e");
    envsh__put_unsigned(t, (uint32_t)(exponent < 0 ? -exponent : exponent));
}

static void envsh__put_floats(envsh__text *t, const float *v, int n)
{
    int i;
    envsh__put(t, "[");
    for (i = 0; i < n; i++) {
        if (i) envsh__put(t, ",");
        envsh__put_float(t, v[i]);
    }
    envsh__put(t, "]");
}

/* The light of a node shines along its -Z: the shortest turn that brings +Z to the direction, x y z w. */
static void envsh__put_node(envsh__text *t, const envsh_light *l, uint32_t i)
{
    envsh__v3 d = envsh__v3_load(l->direction);
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
    envsh__put(t, i ? ",\n" : "\n");
    envsh__put(t, "{\"rotation\":");
    envsh__put_floats(t, q, 4);
    envsh__put(t, ",\"extensions\":{\"KHR_lights_punctual\":{\"light\":");
    envsh__put_unsigned(t, i);
    envsh__put(t, "}}}");
}

static void envsh__put_light(envsh__text *t, const envsh_light *l, uint32_t i)
{
    float color[3], most = l->irradiance[0];
    int c;
    for (c = 1; c < 3; c++)
        if (l->irradiance[c] > most) most = l->irradiance[c];
    for (c = 0; c < 3; c++) color[c] = most > 0.0f ? l->irradiance[c] / most : 1.0f;
    envsh__put(t, i ? ",\n" : "\n");
    envsh__put(t, "{\"type\":\"directional\",\"color\":");
    envsh__put_floats(t, color, 3);
    envsh__put(t, ",\"intensity\":");
    envsh__put_float(t, most);
    envsh__put(t, "}");
}

ENVSH_DEF size_t envsh_export_gltf(const envsh_light *lights, uint32_t count, char *text, size_t size)
{
    envsh__text t;
    uint32_t i;
    if (!lights || (!text && size)) return 0;
    t.out = text;
    t.size = size;
    t.length = 0;
    envsh__put(&t, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"envshadow.h\"}");
    if (count) {
        envsh__put(&t, ",\n\"extensionsUsed\":[\"KHR_lights_punctual\"],\n"
                       "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[");
        for (i = 0; i < count; i++) envsh__put_light(&t, &lights[i], i);
        envsh__put(&t, "]}},\n\"nodes\":[");
        for (i = 0; i < count; i++) envsh__put_node(&t, &lights[i], i);
        envsh__put(&t, "],\n\"scene\":0,\"scenes\":[{\"nodes\":[");
        for (i = 0; i < count; i++) {
            if (i) envsh__put(&t, ",");
            envsh__put_unsigned(&t, i);
        }
        envsh__put(&t, "]}]");
    }
    envsh__put(&t, "}\n");
    if (size) text[t.length < size ? t.length : size - 1] = 0;
    return t.length + 1;
}

/* ---- >>residual ---- */

static envsh_result envsh__check_same(const envsh_lights *l, const envsh_map *map)
{
    size_t texels;
    envsh_result result;
    if (!l || !map) return ENVSH_ERR_ARGUMENT;
    result = envsh__check_map(map, &texels);
    if (result != ENVSH_OK) return result;
    if (map->width != l->map.width || map->height != l->map.height || texels != l->texels) return ENVSH_ERR_ARGUMENT;
    return ENVSH_OK;
}

ENVSH_DEF envsh_result envsh_lights_residual(const envsh_lights *l, const envsh_map *map, float *rgb)
{
    envsh_result result = envsh__check_same(l, map);
    float texel[3];
    size_t t, c;
    if (result != ENVSH_OK) return result;
    if (!rgb) return ENVSH_ERR_ARGUMENT;
    for (t = 0; t < l->texels; t++) {
        uint32_t s = l->strata[t];
        envsh__fetch(map, t, texel);
        for (c = 0; c < 3; c++)
            rgb[3 * t + c] = s == ENVSH_NO_LIGHT ? 0.0f
                                                 : (float)((double)texel[c] - l->sums[s].rgb[c] / l->sums[s].omega);
    }
    return ENVSH_OK;
}

static void envsh__sh9(const double *d, double *y)
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

ENVSH_DEF envsh_result envsh_lights_residual_sh(const envsh_lights *l, const envsh_map *map, float sh[27])
{
    envsh_result result = envsh__check_same(l, map);
    double sum[27], y[9], d[3], omega = 0.0;
    uint32_t w, h, x, row, face, i, j, c;
    size_t t = 0;
    if (result != ENVSH_OK) return result;
    if (!sh) return ENVSH_ERR_ARGUMENT;
    memset(sum, 0, sizeof sum);
    w = map->width;
    h = map->height;
    for (row = 0; row < l->texels / w; row++) {
        face = row / h;
        for (x = 0; x < w; x++, t++) {
            float rgb[3];
            if (l->strata[t] == ENVSH_NO_LIGHT) continue;
            if (x == 0 || l->map.projection == ENVSH_MAP_CUBE || !(omega > 0.0))
                omega = envsh__solid_angle(map, face, x, row % h, l->desc.hemisphere);
            envsh__fetch(map, t, rgb);
            if (!(rgb[0] + rgb[1] + rgb[2] > 0.0f)) continue;
            envsh__direction(map, face, x + 0.5, row % h + 0.5, d);
            envsh__sh9(d, y);
            for (j = 0; j < 27; j++) sum[j] += y[j / 3] * omega * (double)rgb[j % 3];
        }
        omega = 0.0;
    }
    for (i = 0; i < l->count; i++) {
        for (c = 0; c < 3; c++) d[c] = (double)l->list[i].direction[c];
        envsh__sh9(d, y);
        for (j = 0; j < 27; j++) sum[j] -= y[j / 3] * l->sums[i].rgb[j % 3];
    }
    for (j = 0; j < 27; j++) sh[j] = (float)sum[j];
    return ENVSH_OK;
}

ENVSH_DEF void envsh_sh_irradiance(const float sh[27], const float normal[3], float rgb[3])
{
    static const double kernel[9] = { 3.1415926535897932, 2.0943951023931953, 2.0943951023931953, 2.0943951023931953,
                                      0.78539816339744831, 0.78539816339744831, 0.78539816339744831,
                                      0.78539816339744831, 0.78539816339744831 };
    double d[3], y[9], sum;
    int c, j;
    for (c = 0; c < 3; c++) d[c] = (double)normal[c];
    envsh__sh9(d, y);
    for (c = 0; c < 3; c++) {
        sum = 0.0;
        for (j = 0; j < 9; j++) sum += kernel[j] * y[j] * (double)sh[3 * j + c];
        rgb[c] = (float)sum;
    }
}

/* ---- >>maps: the atlas and its views ---- */

#define ENVSH__CELL 8u              /* texels a side of a cell whose depth bounds are kept */
#define ENVSH__NOTHING 1.0f

struct envsh_maps {
    envsh__allocator   allocator;
    envsh_parallel_for parallel_for;
    void              *parallel_user;
    envsh_progress     progress;
    void              *progress_user;
    float        told, span;        /* the part of the whole that the next steps are */
    uint32_t     map_size, guard, capacity, channels, across, down, pages, cells;
    int          no_depth, zero_to_one, top_first;
    int          phase;             /* 0 new, 1 being drawn, 2 ready to be asked */
    uint32_t     count;             /* lights of the last begin */
    envsh_view  *views;
    float       *depth;
    float       *bounds;            /* least and greatest depth of each cell, cells x cells x 2 a tile */
    size_t       bytes;
};

static void envsh__each(envsh_parallel_for parallel, void *user, size_t count, envsh_task task, void *context)
{
    size_t i;
    if (parallel && count > 1) parallel(user, count, task, context);
    else
        for (i = 0; i < count; i++) task(context, i);
}

/* The same in steps, between which the caller may cancel. */
static envsh_result envsh__run(const envsh_maps *m, size_t count, envsh_task task, void *context)
{
    size_t step, steps = m->progress ? 16 : 1;
    envsh__batch batch;
    batch.task = task;
    batch.context = context;
    batch.first = 0;
    for (step = 0; step < steps; step++) {
        size_t next = count / steps * (step + 1) + count % steps * (step + 1) / steps;
        if (m->progress && m->progress(m->progress_user, m->told + m->span * (float)step / (float)steps))
            return ENVSH_ERR_CANCELLED;
        envsh__each(m->parallel_for, m->parallel_user, next - batch.first, envsh__batch_task, &batch);
        batch.first = next;
    }
    return m->progress && m->progress(m->progress_user, m->told + m->span) ? ENVSH_ERR_CANCELLED : ENVSH_OK;
}

static envsh_result envsh__check_maps_desc(envsh_maps_desc *d)
{
    if (!d->map_size) d->map_size = 256;
    if (!d->guard) d->guard = 4;
    if (!d->max_side) d->max_side = d->map_size > 8192 ? d->map_size : 8192;
    if (d->map_size < 16 || d->map_size > 4096 || d->guard > d->map_size / 4) return ENVSH_ERR_DESC;
    if (d->max_side < d->map_size || d->max_side > 32768) return ENVSH_ERR_DESC;
    return envsh__allocator_valid(d->allocator.alloc_fn, d->allocator.free_fn) ? ENVSH_OK : ENVSH_ERR_DESC;
}

/* Tiles fill rows of the widest texture allowed, as square as may be, then pages. */
static void envsh__lay_out(envsh_maps *m, uint32_t max_side)
{
    uint32_t slots = (m->capacity + m->channels - 1) / m->channels, most = max_side / m->map_size, side = 1;
    while (side < most && side * side < slots) side++;
    m->across = slots < side ? slots : side;
    m->down = m->across ? (slots + m->across - 1) / m->across : 0;
    m->down = m->down < most ? m->down : most;
    m->pages = m->across ? (slots + m->across * m->down - 1) / (m->across * m->down) : 0;
}

ENVSH_DEF envsh_result envsh_maps_create(const envsh_maps_desc *desc, uint32_t capacity, envsh_maps **out)
{
    envsh__allocator a;
    envsh_maps_desc d;
    envsh_maps *m;
    envsh_result result;
    size_t texels = 0, cells = 0;
    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    if (!out || capacity > ENVSH_MAX_LIGHTS) return ENVSH_ERR_ARGUMENT;
    result = envsh__check_maps_desc(&d);
    if (result != ENVSH_OK) return result;
    a = envsh__allocator_make(d.allocator.alloc_fn, d.allocator.free_fn, d.allocator.user);
    m = (envsh_maps *)envsh__alloc(&a, sizeof *m);
    if (!m) return ENVSH_ERR_ALLOC;
    memset(m, 0, sizeof *m);
    m->allocator = a;
    m->parallel_for = d.parallel_for;
    m->parallel_user = d.parallel_user;
    m->progress = d.progress;
    m->progress_user = d.progress_user;
    m->span = 1.0f;
    m->map_size = d.map_size;
    m->guard = d.guard;
    m->capacity = capacity;
    m->channels = d.rgba ? 4 : 1;
    m->no_depth = d.no_depth;
    m->zero_to_one = d.clip_zero_to_one;
    m->top_first = d.clip_top_first;
    m->cells = (d.map_size + ENVSH__CELL - 1) / ENVSH__CELL;
    envsh__lay_out(m, d.max_side);
    if (!envsh__mul_size((size_t)m->across * m->map_size, (size_t)m->down * m->map_size, &texels) ||
        !envsh__mul_size(texels, (size_t)m->pages * m->channels, &texels) || texels > SIZE_MAX / 16)
        result = ENVSH_ERR_LIMIT;
    cells = (size_t)m->cells * m->cells * 2 * capacity;
    if (result == ENVSH_OK && capacity) {
        m->views = (envsh_view *)envsh__alloc_array(&a, capacity, sizeof *m->views);
        if (!m->no_depth) m->depth = (float *)envsh__alloc_array(&a, texels, sizeof *m->depth);
        if (!m->no_depth) m->bounds = (float *)envsh__alloc_array(&a, cells, sizeof *m->bounds);
        if (!m->views || (!m->no_depth && (!m->depth || !m->bounds))) result = ENVSH_ERR_ALLOC;
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

ENVSH_DEF void envsh_maps_atlas(const envsh_maps *m, envsh_atlas *out)
{
    if (!m || !out) return;
    out->width = m->across * m->map_size;
    out->height = m->down * m->map_size;
    out->pages = m->pages;
    out->channels = m->channels;
    out->map_size = m->map_size;
    out->guard = m->guard;
    out->capacity = m->capacity;
    out->depth = m->depth;
    out->bytes = m->bytes;
}

ENVSH_DEF const envsh_view *envsh_maps_views(const envsh_maps *m, uint32_t *count)
{
    if (count) *count = m ? m->count : 0;
    return m ? m->views : NULL;
}

/* The tile's corner texel, its row in floats in *row; texels are m->channels floats apart. */
static float *envsh__tile(const envsh_maps *m, uint32_t i, size_t *row)
{
    const envsh_view *v = &m->views[i];
    *row = (size_t)m->across * m->map_size * m->channels;
    return m->depth + ((size_t)v->page * m->down * m->map_size + v->y) * *row + (size_t)v->x * m->channels + v->channel;
}

/* Up to the next sixteenth of an octave, so that a texel's size rests while bounds change a little. */
static float envsh__step_up(float x)
{
    uint32_t bits = envsh__to_bits(x), low = bits & 0x7ffffu;
    return envsh__from_bits(low ? bits - low + 0x80000u : bits);
}

/* Rows of the lookup: texel x and y, depth. */
static void envsh__set_row(float *row, envsh__v3 axis, float scale, float offset)
{
    envsh__v3_store(row, envsh__v3_scale(axis, scale));
    row[3] = offset;
}

static void envsh__clip_matrix(const envsh_maps *m, envsh_view *v)
{
    /* x and y: texels 0..map_size to -1..1; depth as the API wants it. */
    float s = 2.0f / (float)m->map_size, z = m->zero_to_one ? 1.0f : 2.0f, flip = m->top_first ? -1.0f : 1.0f;
    int c;
    for (c = 0; c < 4; c++) {
        v->clip[4 * c] = v->lookup[c] * s - (c == 3 ? 1.0f : 0.0f);
        v->clip[4 * c + 1] = flip * (v->lookup[4 + c] * s - (c == 3 ? 1.0f : 0.0f));
        v->clip[4 * c + 2] = v->lookup[8 + c] * z - (c == 3 && !m->zero_to_one ? 1.0f : 0.0f);
        v->clip[4 * c + 3] = c == 3 ? 1.0f : 0.0f;
    }
}

static void envsh__fit(const envsh_maps *m, const envsh_light *l, const envsh_bounds *b, envsh_view *v)
{
    envsh__v3 axis[3];
    float low[3], high[3], inner = (float)(m->map_size - 2 * m->guard) - 1.0f, diagonal = 0.0f, range, margin;
    int i, j;
    axis[2] = envsh__v3_normalize(envsh__v3_load(l->direction));
    envsh__v3_basis(axis[2], &axis[0], &axis[1]);
    axis[2] = envsh__v3_scale(axis[2], -1.0f);      /* depth grows away from the light */
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
        texel = envsh__step_up(size / inner);
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
        v->spread[i] = envsh__v3_dot(axis[i], envsh__v3_load(l->axis_u)) * range / v->texel[i];
        v->spread[2 + i] = envsh__v3_dot(axis[i], envsh__v3_load(l->axis_v)) * range / v->texel[i];
    }
}

static int envsh__light_finite(const envsh_light *l)
{
    return envsh__v3_finite(envsh__v3_load(l->direction)) && envsh__v3_finite(envsh__v3_load(l->irradiance)) &&
           envsh__v3_length(envsh__v3_load(l->axis_u)) < 1e3f && envsh__v3_length(envsh__v3_load(l->axis_v)) < 1e3f &&
           fabsf(envsh__v3_length(envsh__v3_load(l->direction)) - 1.0f) < 1e-3f;
}

static void envsh__clear_task(void *context, size_t i)
{
    envsh_maps *m = (envsh_maps *)context;
    size_t row, x, y;
    float *tile = envsh__tile(m, (uint32_t)i, &row);
    for (y = 0; y < m->map_size; y++)
        for (x = 0; x < m->map_size; x++) tile[y * row + x * m->channels] = ENVSH__NOTHING;
}

ENVSH_DEF envsh_result envsh_maps_begin(envsh_maps *m, const envsh_light *lights, uint32_t count, envsh_bounds bounds)
{
    uint32_t i;
    int c, empty = 0;
    float size = 0.0f;
    if (!m || (!lights && count) || count > m->capacity) return ENVSH_ERR_ARGUMENT;
    for (i = 0; i < count; i++)
        if (!envsh__light_finite(&lights[i])) return ENVSH_ERR_ARGUMENT;
    for (c = 0; c < 3; c++) {
        if (!(fabsf(bounds.low[c]) <= 1e15f) || !(fabsf(bounds.high[c]) <= 1e15f)) return ENVSH_ERR_ARGUMENT;
        empty |= bounds.low[c] > bounds.high[c];
        if (bounds.high[c] - bounds.low[c] > size) size = bounds.high[c] - bounds.low[c];
    }
    if (empty || !(size > 1e-15f))
        for (c = 0; c < 3; c++) {           /* nothing, or a point: any box round it will do */
            float middle = empty ? 0.0f : bounds.low[c], half = 0.5f + 1e-3f * fabsf(middle);
            bounds.low[c] = middle - half;
            bounds.high[c] = middle + half;
        }
    for (i = 0; i < count; i++) {
        envsh_view *v = &m->views[i];
        uint32_t slot = i / m->channels;
        memset(v, 0, sizeof *v);
        v->channel = i % m->channels;
        v->x = slot % m->across * m->map_size;
        v->y = slot / m->across % m->down * m->map_size;
        v->page = slot / (m->across * m->down);
        memcpy(v->direction, lights[i].direction, sizeof v->direction);
        memcpy(v->irradiance, lights[i].irradiance, sizeof v->irradiance);
        envsh__fit(m, &lights[i], &bounds, v);
        envsh__clip_matrix(m, v);
    }
    m->count = count;
    m->phase = 1;
    if (!m->no_depth) envsh__each(m->parallel_for, m->parallel_user, count, envsh__clear_task, m);
    return ENVSH_OK;
}

/* ---- >>raster: depth of triangles, without a GPU ---- */

typedef struct envsh__draw {
    envsh_maps *maps;
    const envsh_mesh *mesh;
    const float *transform;
    size_t triangles, stride;
} envsh__draw;

typedef struct envsh__corner3 { int64_t x, y; float z; } envsh__corner3;    /* x and y in 256ths of a texel */

/* The edge function's bias: pixels on an edge belong to the triangle whose top or left edge it is. */
static int64_t envsh__edge_bias(const envsh__corner3 *a, const envsh__corner3 *b)
{
    int64_t dx = b->x - a->x, dy = b->y - a->y;
    return dy < 0 || (dy == 0 && dx > 0) ? 0 : -1;
}

static int64_t envsh__edge(const envsh__corner3 *a, const envsh__corner3 *b, int64_t x, int64_t y)
{
    return (b->x - a->x) * (y - a->y) - (b->y - a->y) * (x - a->x);
}

typedef struct envsh__tile_target { float *tile; size_t row, step; int64_t low, high; } envsh__tile_target;

static void envsh__raster(const envsh__tile_target *to, const envsh__corner3 *p, const envsh__corner3 *q,
                          const envsh__corner3 *r)
{
    const envsh__corner3 *swap;
    int64_t area = envsh__edge(p, q, r->x, r->y), x0, x1, y0, y1, x, y, e0, e1, e2, b0, b1, b2;
    float zx, zy, z0, lo, hi;
    double inv;
    if (area == 0) return;
    if (area < 0) {
        swap = q;
        q = r;
        r = swap;
        area = -area;
    }
    x0 = p->x < q->x ? p->x : q->x;
    x1 = p->x < q->x ? q->x : p->x;
    y0 = p->y < q->y ? p->y : q->y;
    y1 = p->y < q->y ? q->y : p->y;
    x0 = ((r->x < x0 ? r->x : x0) + 127) >> 8;       /* first texel whose centre is not left of the box */
    x1 = ((r->x > x1 ? r->x : x1) - 128) >> 8;
    y0 = ((r->y < y0 ? r->y : y0) + 127) >> 8;
    y1 = ((r->y > y1 ? r->y : y1) - 128) >> 8;
    x0 = x0 < to->low ? to->low : x0;
    y0 = y0 < to->low ? to->low : y0;
    x1 = x1 > to->high ? to->high : x1;
    y1 = y1 > to->high ? to->high : y1;
    if (x0 > x1 || y0 > y1) return;
    /* Depth as a plane over the texels, kept within the triangle's own range. */
    inv = 256.0 / (double)area;
    zx = (float)(((double)(q->z - p->z) * (double)(r->y - p->y) - (double)(r->z - p->z) * (double)(q->y - p->y)) * inv);
    zy = (float)(((double)(r->z - p->z) * (double)(q->x - p->x) - (double)(q->z - p->z) * (double)(r->x - p->x)) * inv);
    lo = p->z < q->z ? p->z : q->z;
    hi = p->z < q->z ? q->z : p->z;
    lo = r->z < lo ? r->z : lo;
    hi = r->z > hi ? r->z : hi;
    lo = lo < 0.0f ? 0.0f : lo;             /* nearer than the near plane: still in the way */
    z0 = p->z + zx * ((float)(x0 * 256 + 128 - p->x) / 256.0f) + zy * ((float)(y0 * 256 + 128 - p->y) / 256.0f);
    b0 = envsh__edge(p, q, x0 * 256 + 128, y0 * 256 + 128) + envsh__edge_bias(p, q);
    b1 = envsh__edge(q, r, x0 * 256 + 128, y0 * 256 + 128) + envsh__edge_bias(q, r);
    b2 = envsh__edge(r, p, x0 * 256 + 128, y0 * 256 + 128) + envsh__edge_bias(r, p);
    for (y = y0; y <= y1; y++) {
        float *out = to->tile + (size_t)y * to->row + (size_t)x0 * to->step, zr = z0 + zy * (float)(y - y0);
        e0 = b0;
        e1 = b1;
        e2 = b2;
        for (x = x0; x <= x1; x++, out += to->step) {
            if ((e0 | e1 | e2) >= 0) {
                float z = zr + zx * (float)(x - x0);
                z = z < lo ? lo : z > hi ? hi : z;
                if (z < *out) *out = z;
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

/* World rows times the mesh's transform. */
static void envsh__combine(const float *row, const float *m, float *out)
{
    int c;
    for (c = 0; c < 4; c++) {
        out[c] = row[0] * m[4 * c] + row[1] * m[4 * c + 1] + row[2] * m[4 * c + 2];
        if (c == 3) out[c] += row[3];
    }
}

/* Texels from a tile's corner within which triangles are drawn as they are. What reaches further is cut first: there
   256ths of a texel, and depths in floats, would bend it. */
#define ENVSH__REACH 32768.0

/* 0: not finite or beyond reach, envsh__cut_triangle decides. */
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

typedef struct envsh__point64 { double p[3]; } envsh__point64;      /* texels, texels, depth */

/* Where an edge leaves, from its inner end whichever way it runs: both its triangles get the same point. */
static envsh__point64 envsh__leave(const envsh__point64 *in, const envsh__point64 *out, double din, double dout)
{
    envsh__point64 c;
    int i;
    for (i = 0; i < 3; i++) c.p[i] = in->p[i] + (out->p[i] - in->p[i]) * (din / (din - dout));
    return c;
}

/* Cuts a polygon to the square of all that is within reach (Sutherland and Hodgman 1974). q: room for 8 points. */
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
            if (da >= 0.0 && db < 0.0) r[n++] = envsh__leave(a, b, da, db);
            if (da < 0.0 && db >= 0.0) r[n++] = envsh__leave(b, a, db, da);
        }
        count = n;
        memcpy(q, r, (size_t)n * sizeof *r);
    }
    return count;
}

/* The polygon that is left of a triangle which reaches beyond, in doubles: how many corners. None of one with places
   that floats do not hold. c: room for 8. */
static int envsh__cut_triangle(const float *rows, const float *const *corners, envsh__corner3 *c)
{
    envsh__point64 q[8];
    int i, k, n;
    for (i = 0; i < 3; i++)
        for (k = 0; k < 3; k++) {
            const float *row = rows + 4 * k, *p = corners[i];
            q[i].p[k] = (double)row[0] * (double)p[0] + (double)row[1] * (double)p[1] + (double)row[2] * (double)p[2] +
                        (double)row[3];
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

static void envsh__draw_task(void *context, size_t i)
{
    const envsh__draw *d = (const envsh__draw *)context;
    const envsh_maps *m = d->maps;
    const envsh_view *v = &m->views[i];
    const char *positions = (const char *)d->mesh->positions;
    envsh__tile_target to;
    envsh__corner3 c[8];
    const float *p[3];
    float rows[12];
    size_t t, k;
    to.tile = envsh__tile(m, (uint32_t)i, &to.row);
    to.step = m->channels;
    to.low = (int64_t)m->guard;
    to.high = (int64_t)(m->map_size - m->guard) - 1;
    for (k = 0; k < 3; k++)
        if (d->transform) envsh__combine(v->lookup + 4 * k, d->transform, rows + 4 * k);
        else memcpy(rows + 4 * k, v->lookup + 4 * k, 4 * sizeof *rows);
    for (t = 0; t < d->triangles; t++) {
        int within = 1, n = 3, j;
        for (k = 0; k < 3; k++) {
            size_t index = d->mesh->indices ? d->mesh->indices[3 * t + k] : 3 * t + k;
            p[k] = (const float *)(const void *)(positions + index * d->stride);
            within &= envsh__transform_corner(rows, p[k], &c[k]);
        }
        if (!within) n = envsh__cut_triangle(rows, p, c);
        for (j = 2; j < n; j++) envsh__raster(&to, &c[0], &c[j - 1], &c[j]);
    }
}

static envsh_result envsh__check_mesh(const envsh_mesh *mesh, size_t *triangles)
{
    size_t i, n = mesh->indices ? mesh->index_count : mesh->vertex_count;
    size_t stride = mesh->vertex_stride ? mesh->vertex_stride : 12;
    if (stride < 12 || stride % 4 || n % 3 || (!mesh->positions && n)) return ENVSH_ERR_MESH;
    if (mesh->vertex_count && stride > SIZE_MAX / mesh->vertex_count) return ENVSH_ERR_MESH;
    if (mesh->indices)
        for (i = 0; i < n; i++)
            if (mesh->indices[i] >= mesh->vertex_count) return ENVSH_ERR_MESH;
    *triangles = n / 3;
    return ENVSH_OK;
}

ENVSH_DEF envsh_result envsh_maps_draw(envsh_maps *m, const envsh_mesh *mesh, const float transform[16])
{
    envsh__draw d;
    envsh_result result;
    if (!m || !mesh || (transform && !envsh__m4_is_affine(transform))) return ENVSH_ERR_ARGUMENT;
    if (m->no_depth) return ENVSH_ERR_DESC;
    if (!m->phase) return ENVSH_ERR_ORDER;
    result = envsh__check_mesh(mesh, &d.triangles);
    if (result != ENVSH_OK) return result;
    d.maps = m;
    d.mesh = mesh;
    d.transform = transform;
    d.stride = mesh->vertex_stride ? mesh->vertex_stride : 12;
    m->phase = 1;
    return envsh__run(m, m->count, envsh__draw_task, &d);
}

ENVSH_DEF envsh_result envsh_maps_set(envsh_maps *m, uint32_t light, const float *depth, size_t row_stride)
{
    size_t row, x, y, stride = row_stride;
    float *tile;
    if (!m || !depth || row_stride % 4) return ENVSH_ERR_ARGUMENT;
    if (m->no_depth) return ENVSH_ERR_DESC;
    if (!m->phase) return ENVSH_ERR_ORDER;
    if (light >= m->count) return ENVSH_ERR_ARGUMENT;
    if (!stride) stride = (size_t)m->map_size * 4;
    if (stride < (size_t)m->map_size * 4) return ENVSH_ERR_ARGUMENT;
    tile = envsh__tile(m, light, &row);
    for (y = m->guard; y < m->map_size - m->guard; y++)
        for (x = m->guard; x < m->map_size - m->guard; x++) {
            float z = ((const float *)(const void *)((const char *)depth + y * stride))[x];
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
            envsh__v3 p = envsh__v3_load((const float *)(const void *)((const char *)meshes[i].positions + j * stride));
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

/* Least and greatest depth of each cell, so that most filters need no texel at all. */
static void envsh__bounds_task(void *context, size_t i)
{
    const envsh_maps *m = (const envsh_maps *)context;
    size_t row, x, y;
    float *tile, *out = m->bounds + 2 * i * m->cells * m->cells;
    tile = envsh__tile(m, (uint32_t)i, &row);
    for (y = 0; y < (size_t)m->cells * m->cells; y++) {
        out[2 * y] = ENVSH__NOTHING;
        out[2 * y + 1] = 0.0f;
    }
    for (y = 0; y < m->map_size; y++)
        for (x = 0; x < m->map_size; x++) {
            float z = tile[y * row + x * m->channels], *cell = out + 2 * (y / ENVSH__CELL * m->cells + x / ENVSH__CELL);
            if (z < cell[0]) cell[0] = z;
            if (z > cell[1]) cell[1] = z;
        }
}

ENVSH_DEF envsh_result envsh_maps_end(envsh_maps *m)
{
    if (!m) return ENVSH_ERR_ARGUMENT;
    if (m->no_depth) return ENVSH_ERR_DESC;
    if (!m->phase) return ENVSH_ERR_ORDER;
    envsh__each(m->parallel_for, m->parallel_user, m->count, envsh__bounds_task, m);
    m->phase = 2;
    return ENVSH_OK;
}

/* ---- >>filter: visibility of one light at one point ---- */

typedef struct envsh__lookup {
    const envsh_view *view;
    const float *tile, *cells;      /* cells NULL: no shortcut */
    size_t   row, step;
    int32_t  size, cells_wide;
    const envsh_query *query;
    const float *disc;              /* taps on the unit disc, x and y */
} envsh__lookup;

typedef struct envsh__receiver {
    float x, y, z, gx, gy;          /* texels, depth, and its slope over texels */
    float texel_depth, limit;       /* depth of one texel; how far the slope may bring a tap towards the light */
} envsh__receiver;

/* The plane goes on through walls that stand on it, so it is not followed further towards the light than three texels
   and the radius of a fixed kernel. The penumbra's kernel needs less: what it then takes for a blocker is near, and
   a near blocker makes it small. */
static void envsh__set_limit(envsh__receiver *r, float radius) { r->limit = (radius + 3.0f) * r->texel_depth; }

/* Is the texel's centre on the receiver's plane lit? Beyond the tile nothing is in the way. */
static int envsh__lit(const envsh__lookup *l, const envsh__receiver *r, int32_t x, int32_t y)
{
    float stored, z;
    if (x < 0 || y < 0 || x >= l->size || y >= l->size) return 1;
    stored = l->tile[(size_t)y * l->row + (size_t)x * l->step];
    z = r->gx * ((float)x + 0.5f - r->x) + r->gy * ((float)y + 0.5f - r->y);
    z = r->z + (z < -r->limit ? -r->limit : z);
    return stored >= ENVSH__NOTHING || z <= stored;
}

/* The texel of a coordinate, held where it can be an index. */
static int32_t envsh__texel(float x)
{
    return x < -64.0f ? -64 : x > 8192.0f ? 8192 : (int32_t)floorf(x);
}

/* 1 lit, 0 shadowed all over the kernel of half widths rx, ry; -1 not known. */
static int envsh__decide(const envsh__lookup *l, const envsh__receiver *r, float rx, float ry)
{
    float lo = ENVSH__NOTHING, hi = 0.0f, slope = fabsf(r->gx) * (rx + 1.0f) + fabsf(r->gy) * (ry + 1.0f);
    int32_t x0, x1, y0, y1, x, y, last = l->cells_wide - 1, edge = l->size - 1, outside;
    if (!l->cells) return -1;
    x0 = envsh__texel(r->x - rx);
    x1 = envsh__texel(r->x + rx);
    y0 = envsh__texel(r->y - ry);
    y1 = envsh__texel(r->y + ry);
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

/* All texels whose centres are within radius + 1/2 along both axes, weights falling to 0 at radius + 1. */
static float envsh__smooth(const envsh__lookup *l, const envsh__receiver *r)
{
    float radius = l->query->radius, sum = 0.0f, weights = 0.0f, wx, wy;
    int32_t reach = (int32_t)radius + 1, cx = envsh__texel(r->x), cy = envsh__texel(r->y), x, y;
    for (y = cy - reach; y <= cy + reach; y++) {
        wy = radius + 1.0f - fabsf((float)y + 0.5f - r->y);
        if (!(wy > 0.0f)) continue;
        for (x = cx - reach; x <= cx + reach; x++) {
            wx = radius + 1.0f - fabsf((float)x + 0.5f - r->x);
            if (!(wx > 0.0f)) continue;
            weights += wx * wy;
            if (envsh__lit(l, r, x, y)) sum += wx * wy;
        }
    }
    return weights > 0.0f ? sum / weights : 1.0f;
}

/* Taps on an ellipse of half axes a and b (texels), turned by the unit vector c, s. */
static float envsh__taps(const envsh__lookup *l, const envsh__receiver *r, const float *a, const float *b, float c,
                         float s)
{
    uint32_t i, n = l->query->taps, lit = 0;
    for (i = 0; i < n; i++) {
        float u = l->disc[2 * i] * c - l->disc[2 * i + 1] * s, v = l->disc[2 * i] * s + l->disc[2 * i + 1] * c;
        lit += (uint32_t)envsh__lit(l, r, envsh__texel(r->x + u * a[0] + v * b[0]),
                                    envsh__texel(r->y + u * a[1] + v * b[1]));
    }
    return (float)lit / (float)n;
}

/* Shortens both half axes so that neither reaches beyond `most` texels, and lengthens them to at least 0.7 of one. */
static void envsh__limit(float *a, float *b, float most)
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

/* Half axes of the kernel, texels, where the stratum spreads over a distance in depth. They are held where squares are
   still numbers: beyond, the limit keeps their directions only. */
static float envsh__hold(float x) { return x < -1e15f ? -1e15f : x > 1e15f ? 1e15f : x; }

static void envsh__kernel(const envsh__lookup *l, float distance, float *a, float *b)
{
    const float *spread = l->view->spread;
    int k;
    distance = distance > 0.0f ? distance * l->query->extent_scale : 0.0f;
    distance = distance < 1e9f ? distance : 1e9f;
    for (k = 0; k < 2; k++) {
        a[k] = envsh__hold(spread[k] * distance);
        b[k] = envsh__hold(spread[2 + k] * distance);
    }
    envsh__limit(a, b, l->query->radius);
}

/* Percentage-closer soft shadows for a directional light: the mean depth of what is in the way, then a kernel as wide
   as the stratum spreads over that distance (Fernando 2005; the paper's future work). */
static float envsh__penumbra(const envsh__lookup *l, const envsh__receiver *r, float c, float s)
{
    const envsh_query *q = l->query;
    float a[2], b[2], blockers = 0.0f;
    uint32_t i, found = 0;
    int32_t x, y;
    int known;
    envsh__kernel(l, r->z, a, b);
    known = envsh__decide(l, r, fabsf(a[0]) + fabsf(b[0]), fabsf(a[1]) + fabsf(b[1]));
    if (known >= 0) return (float)known;
    for (i = 0; i < q->taps; i++) {
        float u = l->disc[2 * i] * c - l->disc[2 * i + 1] * s, v = l->disc[2 * i] * s + l->disc[2 * i + 1] * c;
        x = envsh__texel(r->x + u * a[0] + v * b[0]);
        y = envsh__texel(r->y + u * a[1] + v * b[1]);
        if (envsh__lit(l, r, x, y)) continue;
        blockers += l->tile[(size_t)y * l->row + (size_t)x * l->step];
        found++;
    }
    if (!found) return 1.0f;
    envsh__kernel(l, r->z - blockers / (float)found, a, b);
    return envsh__taps(l, r, a, b, c, s);
}

/* Moves the point along its normal and takes it into the tile. cosine: of normal and light, above 0. */
static void envsh__receive(const envsh_view *v, const envsh_query *q, envsh__v3 p, envsh__v3 n, float cosine,
                           envsh__receiver *r)
{
    const float *m = v->lookup;
    float nu = envsh__v3_dot(n, envsh__v3_load(v->right)), nv = envsh__v3_dot(n, envsh__v3_load(v->up));
    float texel = v->texel[0] > v->texel[1] ? v->texel[0] : v->texel[1], sine = sqrtf(nu * nu + nv * nv), steep;
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

static float envsh__visibility(const envsh__lookup *l, envsh__v3 p, envsh__v3 n, float cosine, uint32_t index)
{
    const envsh_query *q = l->query;
    envsh__receiver r;
    float c, s, a[2], b[2];
    int known;
    envsh__receive(l->view, q, p, n, cosine, &r);
    if (!envsh__finite(r.x) || !envsh__finite(r.y) || !envsh__finite(r.z)) return 1.0f;
    if (q->filter == ENVSH_FILTER_PLAIN) return (float)envsh__lit(l, &r, envsh__texel(r.x), envsh__texel(r.y));
    if (q->filter != ENVSH_FILTER_PENUMBRA) {
        float reach = q->filter == ENVSH_FILTER_SMOOTH ? q->radius + 1.0f : q->radius;
        envsh__set_limit(&r, reach);
        known = envsh__decide(l, &r, reach, reach);
        if (known >= 0) return (float)known;
        if (q->filter == ENVSH_FILTER_SMOOTH) return envsh__smooth(l, &r);
    }
    envsh__sincos(6.28318531f * envsh__to_unit(envsh__hash_combine(q->seed, q->first + index)), &s, &c);
    if (q->filter == ENVSH_FILTER_PENUMBRA) return envsh__penumbra(l, &r, c, s);
    a[0] = b[1] = q->radius;
    a[1] = b[0] = 0.0f;
    return envsh__taps(l, &r, a, b, c, s);
}

/* Vogel's spiral: n points evenly over the unit disc. */
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

/* ---- >>shade ---- */

#define ENVSH__BATCH 256u

typedef struct envsh__shading {
    const envsh_maps  *maps;
    const envsh_query *query;
    float    *out;
    uint32_t  only;                 /* one light, or ENVSH_NO_LIGHT: irradiance of all */
    float     disc[2 * ENVSH_MAX_TAPS];
} envsh__shading;

static envsh__v3 envsh__item(const float *base, size_t stride, size_t i)
{
    return envsh__v3_load((const float *)(const void *)((const char *)base + i * (stride ? stride : 12)));
}

/* Light by light over a batch of points, so that a tile's texels are used while they are near. */
static void envsh__shade_light(const envsh__shading *s, uint32_t light, size_t begin, size_t end)
{
    const envsh_maps *m = s->maps;
    const envsh_query *q = s->query;
    const envsh_view *v = &m->views[light];
    envsh__v3 d = envsh__v3_load(v->direction);
    envsh__lookup l;
    size_t i;
    int c;
    l.view = v;
    l.tile = envsh__tile(m, light, &l.row);
    l.cells = m->bounds + 2 * (size_t)light * m->cells * m->cells;
    l.step = m->channels;
    l.size = (int32_t)m->map_size;
    l.cells_wide = (int32_t)m->cells;
    l.query = q;
    l.disc = s->disc;
    for (i = begin; i < end; i++) {
        envsh__v3 p = envsh__item(q->points, q->point_stride, i), n = envsh__item(q->normals, q->normal_stride, i);
        envsh__v3 flat = q->geometric ? envsh__item(q->geometric, q->geometric_stride, i) : n;
        float cosine = envsh__v3_dot(n, d), side = q->geometric ? envsh__v3_dot(flat, d) : cosine, visible;
        if (s->only != ENVSH_NO_LIGHT) {
            s->out[i] = side > 0.0f && envsh__v3_finite(p) ? envsh__visibility(&l, p, flat, side, (uint32_t)i) : 0.0f;
            continue;
        }
        if (!(cosine > 0.0f) || !(side > 0.0f) || !envsh__finite(cosine) || !envsh__v3_finite(p)) continue;
        visible = envsh__visibility(&l, p, flat, side, (uint32_t)i) * cosine;
        for (c = 0; c < 3; c++) s->out[3 * i + (size_t)c] += visible * v->irradiance[c];
    }
}

static void envsh__shade_task(void *context, size_t batch)
{
    const envsh__shading *s = (const envsh__shading *)context;
    size_t begin = batch * ENVSH__BATCH, end = begin + ENVSH__BATCH, i;
    uint32_t light;
    if (end > s->query->count) end = s->query->count;
    if (s->only != ENVSH_NO_LIGHT) {
        envsh__shade_light(s, s->only, begin, end);
        return;
    }
    for (i = 3 * begin; !s->query->add && i < 3 * end; i++) s->out[i] = 0.0f;
    for (light = 0; light < s->maps->count; light++) envsh__shade_light(s, light, begin, end);
}

static envsh_result envsh__check_query(const envsh_query *q)
{
    float most = q->filter == ENVSH_FILTER_SMOOTH ? 8.0f : q->filter == ENVSH_FILTER_PCF ? 32.0f : 64.0f;
    size_t strides[3];
    int i;
    strides[0] = q->point_stride;
    strides[1] = q->normal_stride;
    strides[2] = q->geometric_stride;
    for (i = 0; i < 3; i++)
        if (strides[i] && (strides[i] < 12 || strides[i] % 4)) return ENVSH_ERR_ARGUMENT;
    if (q->count && (!q->points || !q->normals)) return ENVSH_ERR_ARGUMENT;
    if ((unsigned)q->filter >= ENVSH_FILTER_COUNT) return ENVSH_ERR_ARGUMENT;
    if (!(q->bias >= 0.0f && q->bias <= 1e6f)) return ENVSH_ERR_ARGUMENT;
    if (q->filter == ENVSH_FILTER_PLAIN) return ENVSH_OK;
    if (!(q->radius >= (q->filter == ENVSH_FILTER_SMOOTH ? 0.5f : 0.0f))) return ENVSH_ERR_ARGUMENT;
    if (!(q->radius <= most)) return ENVSH_ERR_ARGUMENT;
    if (q->filter == ENVSH_FILTER_SMOOTH) return ENVSH_OK;
    if (q->taps < 1 || q->taps > ENVSH_MAX_TAPS) return ENVSH_ERR_ARGUMENT;
    return q->extent_scale >= 0.0f && q->extent_scale <= 1e6f ? ENVSH_OK : ENVSH_ERR_ARGUMENT;
}

static envsh_result envsh__run_shading(const envsh_maps *m, const envsh_query *q, float *out, uint32_t only)
{
    envsh__shading s;
    envsh_result result;
    size_t batches;
    if (!m || !q || (!out && q->count)) return ENVSH_ERR_ARGUMENT;
    result = envsh__check_query(q);
    if (result != ENVSH_OK) return result;
    if (m->no_depth) return ENVSH_ERR_DESC;
    if (m->phase != 2) return ENVSH_ERR_ORDER;
    if (only != ENVSH_NO_LIGHT && only >= m->count) return ENVSH_ERR_ARGUMENT;
    s.maps = m;
    s.query = q;
    s.out = out;
    s.only = only;
    envsh__fill_disc(s.disc, q->taps && q->taps <= ENVSH_MAX_TAPS ? q->taps : 1);
    batches = q->count / ENVSH__BATCH + (q->count % ENVSH__BATCH != 0);
    return envsh__run(m, batches, envsh__shade_task, &s);
}

ENVSH_DEF envsh_query envsh_query_default(void)
{
    envsh_query q;
    memset(&q, 0, sizeof q);
    q.filter = ENVSH_FILTER_PENUMBRA;
    q.taps = 16;
    q.radius = 12.0f;
    q.bias = 1.0f;
    q.extent_scale = 1.0f;
    return q;
}

ENVSH_DEF envsh_result envsh_shade(const envsh_maps *maps, const envsh_query *query, float *irradiance)
{
    return envsh__run_shading(maps, query, irradiance, ENVSH_NO_LIGHT);
}

ENVSH_DEF envsh_result envsh_visible(const envsh_maps *maps, uint32_t light, const envsh_query *query, float *visible)
{
    if (light == ENVSH_NO_LIGHT) return ENVSH_ERR_ARGUMENT;
    return envsh__run_shading(maps, query, visible, light);
}

ENVSH_DEF float envsh_visibility_twin(const envsh_view *view, const float *depth, size_t row_floats,
                                      size_t texel_floats, uint32_t map_size, const envsh_query *query,
                                      const float point[3], const float geometric[3], uint32_t index)
{
    float disc[2 * ENVSH_MAX_TAPS], cosine;
    envsh__v3 n;
    envsh__lookup l;
    if (!view || !depth || !query || !point || !geometric || envsh__check_query(query) != ENVSH_OK) return 0.0f;
    n = envsh__v3_load(geometric);
    memset(&l, 0, sizeof l);
    envsh__fill_disc(disc, query->taps && query->taps <= ENVSH_MAX_TAPS ? query->taps : 1);
    l.view = view;
    l.tile = depth;
    l.row = row_floats;
    l.step = texel_floats;
    l.size = (int32_t)map_size;
    l.query = query;
    l.disc = disc;
    cosine = envsh__v3_dot(n, envsh__v3_load(view->direction));
    return cosine > 0.0f ? envsh__visibility(&l, envsh__v3_load(point), n, cosine, index) : 0.0f;
}

ENVSH_DEF envsh_result envsh_illuminate(envsh_maps *maps, const envsh_light *lights, uint32_t count,
                                        envsh_bounds bounds, envsh_draw draw, void *user, const envsh_query *query,
                                        float *irradiance)
{
    envsh_query q;
    envsh_result result;
    uint32_t first = 0, n;
    if (!maps || !query || !draw || (!lights && count) || (!maps->capacity && count)) return ENVSH_ERR_ARGUMENT;
    if (envsh__check_query(query) != ENVSH_OK || (!irradiance && query->count)) return ENVSH_ERR_ARGUMENT;
    q = *query;
    do {
        n = count - first < maps->capacity ? count - first : maps->capacity;
        maps->told = count ? (float)first / (float)count : 0.0f;
        maps->span = 0.0f;
        result = envsh_maps_begin(maps, lights ? lights + first : NULL, n, bounds);
        if (result == ENVSH_OK && n) result = draw(user, maps);
        if (result == ENVSH_OK) result = envsh_maps_end(maps);
        maps->span = (count ? (float)(first + n) / (float)count : 1.0f) - maps->told;
        if (result == ENVSH_OK) result = envsh_shade(maps, &q, irradiance);
        q.add = 1;
        first += n;
    } while (result == ENVSH_OK && first < count);
    maps->told = 0.0f;
    maps->span = 1.0f;
    return result;
}

/* ---- >>cost ---- */

ENVSH_DEF int envsh_cost_fit(uint32_t light_count, const uint32_t *sizes, const double *ms, size_t count,
                             envsh_cost *out)
{
    double aa = 0.0, ab = 0.0, bb = 0.0, at = 0.0, bt = 0.0, det;
    size_t i;
    if (!sizes || !ms || !out || !light_count) return 0;
    for (i = 0; i < count; i++) {
        double passes, slots;
        if (!sizes[i] || !(ms[i] >= 0.0 && ms[i] < 1e12)) return 0;
        passes = (double)((light_count - 1) / sizes[i] + 1);
        slots = passes * (double)sizes[i];
        /* Relative errors count: each row is divided by its time. */
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
    if (out->pass < 0.0) {                  /* noise: what is left explains all of it */
        out->pass = 0.0;
        out->slot = bt / bb;
    } else if (out->slot < 0.0) {
        out->slot = 0.0;
        out->pass = at / aa;
    }
    return 1;
}

ENVSH_DEF uint32_t envsh_cluster_size(const envsh_cost *cost, uint32_t light_count, uint32_t most)
{
    uint32_t best = 1, c;
    double least = -1.0;
    if (!cost || !light_count || !most) return 1;
    most = most < light_count ? most : light_count;
    for (c = 1; c <= most; c++) {
        double passes = (double)((light_count - 1) / c + 1), ms = passes * (cost->pass + (double)c * cost->slot);
        if (least >= 0.0 && ms >= least) continue;
        least = ms;
        best = c;
    }
    return best;
}

/* >>> shared fp_end: written by tools/stamp from src/shared, edit there */

/* unit fp_end: the user's options again. clang and MSVC keep contraction off to the end of the file. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__)
#pragma GCC pop_options
#endif

/* <<< shared */

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
