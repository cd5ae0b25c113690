/* ---- layers from your own renderer ---- */

typedef struct cohsm_builder cohsm_builder; /* makes maps of layers that you render, one view at a time */

typedef struct cohsm_view {         /* the camera of one map, or of one face of a map of a position */
    uint32_t index;                 /* 0..view count - 1, in sequence */
    uint32_t cell;                  /* the map's number, 0..N - 1, as cohsm_location counts */
    float matrix[16];               /* column-major; object space to x, y in 0..M (pixels, y up) and z, the
                                       linear depth in 0..1; perspective faces give (x w, y w, -, w), and
                                       their depth is w * depth_scale */
    float depth_scale;              /* of perspective views; 0 for orthographic ones */
    float location[4];              /* x, y, z, w: D of this view */
    uint32_t face;                  /* 0..5: +X -X +Y -Y +Z -Z; 0 for orthographic views */
} cohsm_view;

COHSM_DEF cohsm_result cohsm_builder_create(const cohsm_desc *desc, cohsm_builder **out);
/* Makes a builder, which cohsm_builder_free takes back. It never holds all maps: its memory is that of
   cohsm_build without the triangles. Since it knows no mesh, cohsm_visible refuses the semi-local lights
   inside the bounding sphere, in place of those inside the object's hull.
   desc     needs a radius > 0
   Errors   COHSM_ERR_ARGUMENT, COHSM_ERR_DESC, COHSM_ERR_LIMIT, COHSM_ERR_ALLOC */

COHSM_DEF uint32_t cohsm_builder_view_count(const cohsm_builder *builder);
/* Returns how many views must be rendered: N, or 6 N for positions. */

COHSM_DEF cohsm_result cohsm_builder_view(const cohsm_builder *builder, uint32_t index, cohsm_view *out);
/* Writes the camera of a view.
   Errors   COHSM_ERR_ARGUMENT (NULL, or an index that is too large) */

COHSM_DEF cohsm_result cohsm_builder_add(cohsm_builder *builder, uint32_t index, const float *z1,
                                         const float *z2, const float *z3);
/* Takes the layers of a view and compresses them.
   index        counts up from 0 with each call
   z1, z2, z3   M * M depths in 0..1 each (the view's z; row 0 is y = 0), or above 1 where there is no such
                hit, with z1 <= z2 <= z3; z3 may be NULL with COHSM_LAYERS_Z1Z2
   Errors       COHSM_ERR_ARGUMENT, COHSM_ERR_ORDER, COHSM_ERR_INPUT (NaN, or layers out of order; the view
                may be given again), COHSM_ERR_ALLOC (the builder can only be freed then) */

COHSM_DEF cohsm_result cohsm_builder_finish(cohsm_builder *builder, cohsm_maps **out, cohsm_stats *stats);
/* Makes the maps after the last view; the builder can only be freed then.
   stats    may be NULL
   Errors   COHSM_ERR_ARGUMENT, COHSM_ERR_ORDER, COHSM_ERR_LIMIT, COHSM_ERR_ALLOC */

COHSM_DEF void cohsm_builder_free(cohsm_builder *builder);
/* Takes back a builder and its memory. Accepts NULL. */

/* ---- large builds in pieces ---- */

COHSM_DEF cohsm_result cohsm_merge(const cohsm_maps *const *shards, size_t count, const cohsm_system *system,
                                   cohsm_maps **out);
/* Joins shards of one desc whose ranges of pixels follow each other from 0 to M * M. The bytes are those of
   the build in one piece.
   system   NULL: malloc and free, no progress
   Errors   COHSM_ERR_ARGUMENT, COHSM_ERR_DESC (allocator), COHSM_ERR_MISMATCH, COHSM_ERR_LIMIT,
            COHSM_ERR_ALLOC, COHSM_ERR_CANCELLED */

/* ---- checking a build ---- */

typedef struct cohsm_report {
    uint64_t entries;               /* pixels x views that were compared */
    uint64_t wrong;                 /* stored depths outside of their interval: 0, or the block is not
                                       lossless */
    uint64_t empty;                 /* stored at z1 as promised, as cohsm_stats.empty_intervals */
    uint32_t first_view, first_pixel;   /* of the first wrong entry; views count in sequence, as
                                       cohsm_view.index */
} cohsm_report;

COHSM_DEF cohsm_result cohsm_verify(const cohsm_maps *maps, const cohsm_system *system,
                                    const cohsm_mesh *mesh, cohsm_report *out);
/* Renders every view of the mesh again and compares every stored depth with the layers that it must separate
   (equation 1). COHSM_OK says that this was done: out->wrong has the result.
   system   NULL: malloc and free, this thread alone, no progress
   Errors   those of cohsm_build */

COHSM_DEF cohsm_result cohsm_depths(const cohsm_maps *maps, uint32_t view, uint16_t *out);
/* Decompresses one map, for tests, and for renderers that want one plain shadow map. Writes the stored
   depths z * 65533 of its pixels, all M * M or those of a shard, row 0 at y = 0; 65534 is open to the
   sphere's far side, 65535 is infinity.
   view     the map's number, or face * N + number
   Errors   COHSM_ERR_ARGUMENT (NULL, or a view that is too large)
   Cost     M^2 searches */
