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
