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
