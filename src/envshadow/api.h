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

typedef struct envsh_bounds { float low[3], high[3]; } envsh_bounds;    /* of the casters, world space */

typedef struct envsh_lights envsh_lights;           /* arrays of directional lights: below */
typedef struct envsh_mesh envsh_mesh;               /* triangles that cast shadows: below */
typedef struct envsh_points envsh_points;           /* arrays of receivers: below */
typedef struct envsh_maps envsh_maps;               /* shadow maps of some lights */
typedef struct envsh_maps_desc envsh_maps_desc;     /* how large they are: below */
typedef struct envsh_query envsh_query;             /* how they are filtered: below */

ENVSH_DEF envsh_result envsh_maps_create(const envsh_maps_desc *desc, uint32_t capacity, envsh_maps **out);
/* Makes room for shadow maps, which envsh_maps_free takes back.
   desc      NULL = all defaults: 256 x 256 texels a light
   capacity  lights held at once: all of them (the paper's algorithm 1), or a cluster (its algorithm 2,
             envsh_illuminate); 0 is allowed
   out       written on ENVSH_OK only
   Errors    ENVSH_ERR_ARGUMENT (out, capacity above ENVSH_MAX_LIGHTS), ENVSH_ERR_DESC, ENVSH_ERR_LIMIT,
             ENVSH_ERR_ALLOC */

ENVSH_DEF envsh_bounds envsh_bounds_of(const envsh_mesh *meshes, size_t count, const float *transforms);
/* Returns the bounds of all finite vertices; low > high: there are none.
   transforms  16 floats for each mesh, mesh to world, affine; NULL = identity */

ENVSH_DEF envsh_result envsh_maps_begin(envsh_maps *maps, const envsh_lights *lights, envsh_bounds bounds);
/* Begins a frame: clears all tiles and fits them to bounds. Sizes go in steps of a sixteenth of an octave and
   corners on whole texels, so that small changes of the bounds move no texel of a resting light. Casters
   outside are cut, those nearer to the light kept. Empty bounds: nothing casts shadows.
   lights  NULL = none
   Errors  ENVSH_ERR_ARGUMENT: NULL, a count above capacity, a stride, one array of axes without the other;
           ENVSH_ERR_INPUT: a light that is not finite, has a direction that is not unit, or an axis of 1e3 or
           more; bounds not finite or beyond 1e15 */

ENVSH_DEF envsh_result envsh_maps_draw(envsh_maps *maps, const envsh_mesh *mesh, const float transform[16]);
/* Renders the depth of a mesh into every tile: texel centres, top-left rule, both sides. Triangles with a
   vertex that is not finite are left out.
   transform  mesh to world, affine; NULL = identity
   Errors  ENVSH_ERR_ARGUMENT: NULL, a stride; ENVSH_ERR_INPUT: an index, a count that is no multiple of 3, a
           transform that is not affine; ENVSH_ERR_ORDER; ENVSH_ERR_DESC with no_depth; ENVSH_ERR_CANCELLED:
           some tiles have the mesh, others not; begin anew */

ENVSH_DEF envsh_result envsh_maps_end(envsh_maps *maps);
/* Says that all is drawn: makes the depth bounds of cells that shading needs. A later draw or set asks for
   another end. */

ENVSH_DEF envsh_result envsh_shade(const envsh_maps *maps, const envsh_query *query,
                                   const envsh_points *points,
                                   float *irradiance);
/* Writes for each point the sum over all lights of visibility x cosine x irradiance: 3 floats, W/m^2; times
   albedo / pi it is the radiance of a diffuse surface. Points or normals that are not finite give 0.
   query   NULL = all defaults
   Errors  ENVSH_ERR_ARGUMENT: NULL, a stride; ENVSH_ERR_DESC: a field of the query, or no_depth;
           ENVSH_ERR_INPUT: a normal that is not unit; ENVSH_ERR_ORDER; ENVSH_ERR_CANCELLED: some points may
           be done */

ENVSH_DEF void envsh_maps_free(envsh_maps *maps);
/* Takes back the maps and their memory; NULL is allowed. */

ENVSH_DEF const char *envsh_result_text(envsh_result result);
/* Returns a constant string for any value, "unknown result" beyond the list. */

/* ---- structs of page one ---- */

struct envsh_lights {       /* directional lights from anywhere: envlights.h makes them of a sky; or
                                       your own */
    uint32_t     count;
    const float *directions;        /* x, y, z of each light, unit, towards it */
    const float *irradiances;       /* red, green, blue on a plane that faces the light, W/m^2 */
    const float *axes_u, *axes_v;   /* extent: half axes of the ellipse over which the light is spread, at
                                       right angles to its direction, tangents of angles, below 1e3; both NULL
                                       = no extent */
    size_t       stride;            /* bytes from one light to the next, in each of the arrays, a multiple of
                                       4, >= 12; 0 = 12 */
};

struct envsh_mesh {         /* what casts shadows */
    const float    *positions;      /* x, y, z of each vertex */
    size_t          vertex_count;
    size_t          vertex_stride;  /* bytes from one vertex to the next, a multiple of 4, >= 12; 0 = 12 */
    const uint32_t *indices;        /* three to a triangle; NULL = indices16, or else 0, 1, 2, ... */
    size_t          index_count;    /* a multiple of 3 (ignored without indices: vertex_count is used) */
    const uint16_t *indices16;      /* in place of indices; not both */
};

struct envsh_points {       /* receivers */
    size_t       count;
    const float *positions;         /* x, y, z of each, world space */
    size_t       position_stride;   /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const float *normals;           /* unit shading normals, for the cosine; 0 0 0: no receiver, its results
                                       are 0 */
    size_t       normal_stride;     /* bytes, a multiple of 4, >= 12; 0 = 12 */
    const float *geometric_normals; /* unit normals of the surface itself, for offsets and which side it is;
                                       NULL = normals. 0 0 0: results are 0 */
    size_t       geometric_normal_stride;   /* bytes, a multiple of 4, >= 12; 0 = 12 */
    uint32_t     first;             /* the number of point 0: point i turns its taps by (query.seed, first +
                                       i) */
};

/* ---- memory, threads, progress, log: the caller's ---- */

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

#define ENVSH_MAX_LIGHTS 8192u
#define ENVSH_MAX_TAPS 64u

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
    envsh_system system;            /* progress: of each envsh_maps_draw, envsh_shade and envsh_visible.
                                       envsh_illuminate counts as one call: shading advances, draws only ask
                                       whether to go on */
    uint32_t map_side;              /* texels a side of a tile, guard included, 16..4096; 0 = 256 */
    uint32_t guard;                 /* empty texels on each side, 1..map_side / 4; 0 = 4 */
    uint32_t max_side;              /* of the atlas texture, map_side..32768; 0 = 8192. Further tiles go to
                                       pages */
    int      rgba;                  /* not 0: four tiles share a texel's channels */
    int      no_depth;              /* not 0: layout and matrices only, for maps that your GPU renders */
    envsh_rows       rows;          /* of envsh_view.clip: of the textures that your GPU renders */
    envsh_clip_depth clip_depth;    /* of envsh_view.clip, and of the depth that envsh_maps_set takes */
};

typedef enum envsh_filter {
    ENVSH_FILTER_DEFAULT,           /* = ENVSH_FILTER_PENUMBRA */
    ENVSH_FILTER_PLAIN,             /* one texel */
    ENVSH_FILTER_SMOOTH,            /* the paper's smoothing: all texels within radius, weights falling
                                       linearly */
    ENVSH_FILTER_PCF,               /* the paper's percentage closer filtering: taps jittered within radius */
    ENVSH_FILTER_PENUMBRA,          /* taps within the penumbra: extent x distance to the blockers found */
    ENVSH_FILTER_COUNT
} envsh_filter;

struct envsh_query {                /* zero it, then set what you care about */
    envsh_filter filter;
    uint32_t     taps;              /* of PCF and PENUMBRA, 1..ENVSH_MAX_TAPS; 0 = 16 */
    float        radius;            /* texels. SMOOTH: 0.5..8, 0 = 2; PCF: up to 32, 0 = 2, negative = none;
                                       PENUMBRA: the most, up to 64, 0 = 12, negative = none */
    float        bias;              /* texels along the geometric normal at grazing light; 0 = 1, negative =
                                       none */
    float        extent_scale;      /* PENUMBRA: factor on the lights' extents; 0 = 1, negative = no extent */
    uint32_t     seed;              /* of the taps' rotation */
    int          add;               /* not 0: envsh_shade adds to the output */
};

/* ---- one light, clusters of lights ---- */

ENVSH_DEF envsh_result envsh_visible(const envsh_maps *maps, uint32_t light, const envsh_query *query,
                                     const envsh_points *points, float *visible);
/* Writes the visibility of one light from each point, 0..1, for your own BRDF; 0 behind the geometric
   surface. query.add is ignored.
   Errors  as envsh_shade; ENVSH_ERR_ARGUMENT for a light that the maps do not hold */

typedef envsh_result (*envsh_draw_fn)(void *user, envsh_maps *maps);
/* Must call envsh_maps_draw or envsh_maps_set for everything that casts shadows. */

ENVSH_DEF envsh_result envsh_illuminate(envsh_maps *maps, const envsh_lights *lights, envsh_bounds bounds,
                                        envsh_draw_fn draw_fn, void *user, const envsh_query *query,
                                        const envsh_points *points, float *irradiance);
/* Is the paper's algorithm 2: for each cluster of as many lights as there is capacity, draws their maps and
   adds their light. With a capacity for all lights it is algorithm 1. The sums are the same, to the bit, for
   every capacity.
   Errors  those of envsh_maps_begin,
       envsh_shade (of query and points before anything is drawn) and draw_fn */

/* ---- maps for and from your own renderer ---- */

typedef struct envsh_view {         /* one light's shadow map: what your renderer or shader needs of it */
    float    clip[16];              /* world to clip space of the tile's viewport */
    float    lookup[12];            /* rows of 4: world to x and y in texels of the tile (0 = its edge), and
                                       depth */
    float    right[3], up[3];       /* unit axes of the tile, at right angles to the direction */
    float    direction[3], irradiance[3];
    float    texel[2];              /* world size of a texel, in x and y */
    float    depth_range;           /* world distance of depth 0..1 */
    float    spread[4];             /* extent: axis_u's x, y and axis_v's x, y, in texels for a blocker depth
                                       1 away */
    uint32_t x, y, page, channel;   /* of the tile in the atlas: texels of its corner */
    uint32_t guard;                 /* texels on each side of the tile that have to stay empty */
} envsh_view;

typedef struct envsh_info {         /* the atlas */
    uint32_t width, height, pages, channels;   /* channels: 1 or 4 */
    uint32_t map_side, guard, capacity;
    float   *depth;                 /* channels floats a texel, row by row, page by page: 0 near .. 1 far.
                                       NULL with no_depth */
    size_t   bytes;                 /* all that the object keeps */
} envsh_info;

ENVSH_DEF void envsh_get_info(const envsh_maps *maps, envsh_info *out);
/* Writes how the tiles lie in memory; nothing where a pointer is NULL. */

ENVSH_DEF const envsh_view *envsh_get_views(const envsh_maps *maps, uint32_t *count);
/* Returns a view for each light of the last envsh_maps_begin, valid until the next. NULL for NULL; count may
   be NULL. */

ENVSH_DEF envsh_result envsh_maps_set(envsh_maps *maps, uint32_t light, const float *depth,
                                      size_t row_stride);
/* Copies a tile from your own renderer: map_side rows of map_side depths, row 0 at y = 0. The guard is kept
   empty whatever is given. NaN counts as nothing there.
   row_stride  bytes from one row to the next, a multiple of 4; 0 = packed */

typedef struct envsh_tile {         /* a tile in memory of yours */
    const envsh_view *view;
    const float      *depth;        /* its corner texel and channel; 0 near .. 1 far */
    size_t            row_stride, texel_stride;    /* bytes, multiples of 4 */
    uint32_t          side;         /* texels */
} envsh_tile;

ENVSH_DEF float envsh_visibility_twin(const envsh_tile *tile, const envsh_query *query, const float point[3],
                                      const float geometric_normal[3], uint32_t index);
/* Returns the visibility of one tile's light from one point: the C twin of the GLSL function, without the
   shortcut of cells that envsh_visible takes. The answers are the same; 0 where a pointer is NULL or the
   query is one that envsh_visible refuses. */

/* ---- how many lights a pass: the cost model ---- */

typedef struct envsh_cost {         /* milliseconds of a frame with clusters of c: passes = ceil(k / c) */
    double pass;                    /* each pass, whatever it holds: state, geometry, fetching the surface */
    double slot;                    /* each of the passes x c places for a light, filled or not */
} envsh_cost;

ENVSH_DEF int envsh_cost_fit(uint32_t light_count, const uint32_t *clusters, const double *ms, size_t count,
                             envsh_cost *out);
/* Finds the costs by least squares through times measured with clusters of clusters[i] lights, two different
   ones or more. Returns 0 where they cannot be found. */

ENVSH_DEF uint32_t envsh_cost_cluster(const envsh_cost *cost, uint32_t light_count, uint32_t most);
/* Returns the c of 1..most with the least passes x pass + passes x c x slot; among equals the smallest, which
   needs the least memory. most: what your atlas, uniforms or instruction limit allow. */

#ifdef __cplusplus
}
#endif

#endif /* ENVSHADOW_H */
