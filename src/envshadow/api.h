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
