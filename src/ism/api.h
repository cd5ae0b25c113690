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
