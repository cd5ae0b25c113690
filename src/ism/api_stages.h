/* ---- stage by stage: what ism_render does ---- */

ISM_DEF ism_result ism_choose(ism_maps *maps, const ism_frame *frame);
/* Chooses VPLs among the texels of the frame's sources, by their importance (section 4). VPL i lies at (i +
   0.5) / N of the sum of all importances. Black sources give no VPLs, which is no error.
   Errors   ISM_ERR_ARGUMENT (NULL, the points' arrays or strides), ISM_ERR_INPUT (a source's arrays or
            strides, vectors that are not unit), ISM_ERR_LIMIT (2^26 texels), ISM_ERR_ALLOC,
            ISM_ERR_CANCELLED */

ISM_DEF ism_result ism_build(ism_maps *maps, const ism_frame *frame);
/* Renews surfels (section 5) and draws the maps of the VPLs that there are (sections 3.3, 6.1). Surfels are
   kept as barycentric coordinates: if the number of triangles stays the same, those that are not renewed
   follow the mesh; if it changes, all are made anew.
   Errors   ISM_ERR_ARGUMENT, ISM_ERR_ORDER (no VPLs were chosen), ISM_ERR_INPUT (strides, an index beyond
            vertex_count, vectors that are not unit), ISM_ERR_LIMIT, ISM_ERR_ALLOC, ISM_ERR_CANCELLED
   Cost     O(triangles + surfels of all VPLs x texels of their discs) */

ISM_DEF ism_result ism_shade(const ism_maps *maps, const ism_points *points, const ism_shading *shading,
                             float *out, ism_stats *stats);
/* Lights receivers by all VPLs, those of the frame or any others. shading, out and stats are as in
   ism_render; stats->peak_bytes counts what the call allocates while it runs.
   Errors   ISM_ERR_ARGUMENT, ISM_ERR_DESC, ISM_ERR_ORDER, ISM_ERR_INPUT (vectors that are not unit),
            ISM_ERR_LIMIT, ISM_ERR_ALLOC, ISM_ERR_CANCELLED */

/* ---- VPLs: to look at, to upload, or of your own ---- */

typedef struct ism_vpl {
    float    position[3];           /* of directions: the unit direction to the light */
    float    normal[3];             /* unit; of directions: the opposite */
    float    flux[3];               /* W; of directions irradiance facing it, W/m^2 */
    float    axis[3], exponent;     /* of the lobe; the normal and 1 if it is diffuse */
    float    area;                  /* m^2 that it stands for; 0 = estimated from the distances of VPLs */
    float    side;                  /* m: of the square that ISM_NEAR_PATCH takes; set by ism_choose and
                                       ism_set_vpls */
    int32_t  directional;           /* not 0: of a source of directions */
    uint32_t source, texel;         /* where it comes from; texel = y * width + x */
    int32_t  jumped;                /* 1: not where it was in the last frame, by more than a texel; of
                                       directions, scattered sources and with no_inter_texel: at all */
    float    reach;                 /* m: near points light receivers within it, fully so within 0.7 of it. 0
                                       = none do; set by ism_choose and ism_set_vpls */
    uint32_t window;                /* of its tile, see ism_zoom; set by ism_build and ism_scatter */
} ism_vpl;

ISM_DEF const ism_vpl *ism_vpls(const ism_maps *maps, size_t *count);
/* Returns the VPLs, valid until the next stage. */

ISM_DEF ism_result ism_set_vpls(ism_maps *maps, const ism_vpl *vpls, size_t count);
/* Takes your own list in place of ism_choose, without near points. count <= N; vectors must be finite, flux
   0..1e30, normal and axis unit. Errors: ISM_ERR_ARGUMENT, ISM_ERR_INPUT, ISM_ERR_LIMIT,
   ISM_ERR_CANCELLED. */

typedef struct ism_near_point {     /* 48 bytes: gl_backend uploads them as they are */
    float position[3], side;        /* m: of the square that it becomes */
    float normal[3], reach;         /* m: as a VPL's */
    float flux[3];                  /* W */
    float vpl;                      /* whole number of the VPL nearest to it, by whose map it is seen */
} ism_near_point;

ISM_DEF const ism_near_point *ism_near_points(const ism_maps *maps, size_t *count);
/* Returns a second, finer choice by the same importances, near_point_count times as many: of surfaces without
   lobes alone, 64 neighbours in space together. There are none where VPLs on such surfaces are fewer than 9,
   or set by ism_set_vpls. A receiver at distance d takes VPLs by 1 - h and near points by h = 2 - 2 d^2 /
   reach^2, limited to 0..1: where VPLs are few and near the sum is that of many. Valid until the next
   ism_choose or ism_set_vpls. */

ISM_DEF const float *ism_importances(const ism_maps *maps, size_t source, size_t *count);
/* Returns the importances of a source's texels (its bidirectional reflective shadow map) as ism_choose left
   them; NULL beyond the last source, and after a choice that failed. */

/* ---- surfels: for those who draw the maps themselves, as gl_backend does ---- */

ISM_DEF ism_result ism_scatter(ism_maps *maps, const ism_frame *frame);
/* Does the first half of ism_build: surfels and windows, but no maps. Errors: those of ism_build. */

typedef struct ism_surfel {         /* 16 bytes: gl_backend uploads them as they are */
    uint32_t triangle;
    float    barycentric[2];        /* weights of its second and third corner */
    float    area;                  /* that it stands for, as a share of its triangle's */
} ism_surfel;

ISM_DEF ism_result ism_surfels(const ism_maps *maps, uint32_t vpl, ism_surfel *out, size_t capacity,
                               size_t *count);
/* Writes the surfels of one VPL's tile: *count of them, at most capacity (out may be NULL if capacity is 0).
   Errors: ISM_ERR_ARGUMENT, ISM_ERR_ORDER. */

ISM_DEF ism_result ism_phase_surfels(const ism_maps *maps, uint32_t phase, ism_surfel *out, size_t capacity,
                                     size_t *count);
/* Writes, of every VPL in turn, the surfels phase, phase + lazy_frames, phase + 2 lazy_frames ..., as many of
   each as surfel_count / lazy_frames rounded up; those that a VPL does not have get area 0. A frame renews
   the phase index % lazy_frames alone, or all (stats.renewed).
   phase    below lazy_frames
   count    of all of them; at most capacity are written (out may be NULL if capacity is 0)
   Errors   ISM_ERR_ARGUMENT, ISM_ERR_ORDER */

/* ---- maps ---- */

typedef struct ism_info {
    ism_stats stats;                /* of the last ism_choose, ism_build or ism_scatter */
    uint32_t vpl_count;             /* in use */
    uint32_t near_point_count;      /* in use */
    uint32_t surfel_count, tile_side, lazy_frames;  /* as in ism_desc, with defaults in place of zeros */
    float    center[3], radius;     /* the sphere about the mesh of the last ism_build or ism_scatter, which
                                       maps of directions cover */
} ism_info;

ISM_DEF void ism_get_info(const ism_maps *maps, ism_info *out);
/* Writes what the maps hold. */

#define ISM_FAR 1e30f               /* depth of a texel that shows nothing */

ISM_DEF const float *ism_atlas(const ism_maps *maps, uint32_t *side, uint32_t *tiles_across);
/* Returns side * side depths, a tile for each VPL: the distance from the VPL to the surface in the direction
   of the texel's centre, or ISM_FAR. Tile i lies at column i % tiles_across and row i / tiles_across. Returns
   NULL before ism_build; side and tiles_across may be NULL. */

ISM_DEF ism_result ism_visible(const ism_maps *maps, uint32_t vpl, const ism_points *points, float bias,
                               float *visible);
/* Writes for each receiver whether ism_shade would light it by this VPL: 1 or 0. Receivers behind the VPL are
   lit, those that turn their geometric normal's back to it are not. bias as in ism_shading. Errors:
   ISM_ERR_ARGUMENT, ISM_ERR_ORDER, ISM_ERR_INPUT (vectors that are not unit). */
