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
