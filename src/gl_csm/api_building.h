/* ---- building on the GPU ----

   A builder of this header draws the layers of views by depth peeling and finds their segments (equation 1).
   csm.h then writes the block from the segments alone; its bytes are those which its builder would have made
   of the layers that were drawn, with COHSM_LAYERS_Z1Z3_SPHERE but for roundings of where rays leave the
   sphere. Views come in batches:

       for (from = 0; from < view_count; from += n) {              // n <= b.batch
           glbk_csm_builder_draw(gl, &b, from, n);
           glbk_csm_builder_compress(gl, &b);
       }
       glbk_csm_builder_end(gl, &b);
       cohsm_builder_import(builder, b.segments, b.segment_count);
       cohsm_builder_finish(builder, &maps, NULL); */

typedef void (*glbk_csm_view_fn)(void *user, uint32_t index, cohsm_view *out);
/* Writes the camera of a view, as cohsm_builder_view does. The builder reads matrix and depth_scale, and of
   views of positions with COHSM_LAYERS_Z1Z3_SPHERE also location and face. */

typedef void (*glbk_csm_draw_fn)(void *user, glbk_context *ctx);
/* Draws your object: it binds a vertex array with the position in object space, and draws. It changes neither
   program nor state. */

typedef struct glbk_csm_builder_desc {
    const cohsm_desc *maps;             /* the desc that cohsm_builder_create gets; NULL = all defaults. Here
                                           map_side, layers, depth_bits, open_thickness and self_only count,
                                           with COHSM_LAYERS_Z1Z3_SPHERE center and radius, which must be
                                           above 0, and whether domain is of positions. Views are drawn whole,
                                           also for a shard */
    glbk_csm_view_fn  view_fn;          /* required, like draw_fn */
    glbk_csm_draw_fn  draw_fn;
    void             *user;             /* given to both */
    glbk_attributes   attributes;       /* of your object: position counts, all zero = 0 */
} glbk_csm_builder_desc;                /* maps is read until glbk_csm_builder_create returns */

typedef struct glbk_csm_builder {       /* read only; zeroed = none */
    uint32_t              batch;        /* the most views that are drawn at once, a power of two */
    uint32_t              tiles;        /* private, like all that follows: tiles in a row of the atlas */
    uint32_t              drawn;        /* views that glbk_csm_builder_draw drew last */
    uint32_t              drawn_from;   /* the first of them */
    uint32_t              next_view;    /* the first that is not compressed yet */
    uint32_t              passes;       /* runs of the shader that compresses */
    uint32_t              map_side;     /* of the desc's maps, like the next five, without defaults */
    uint32_t              depth_bits;
    uint32_t              layer_count;
    float                 open_thickness;
    int                   positional;
    int                   self_only;
    int                   sphere;
    float                 center[3], radius;
    float                 eyes[64][4];  /* of the views drawn last: see glbk_csm_peel */
    glbk_csm_view_fn      view_fn;
    glbk_csm_draw_fn      draw_fn;
    void                 *user;
    glbk_program          first_layer;
    glbk_program          next_layer;
    glbk_program          compress;
    glbk_texture          layers[3];    /* an atlas of tiles each */
    glbk_texture          depth;
    glbk_texture          opened[2];    /* core path: open segments, read from one and written to the other */
    glbk_texture          records[3];   /* core path */
    glbk_target           layer_targets[3];
    glbk_target           targets[2];
    glbk_buffer           block;
    glbk_buffer           storage;      /* compute path: open segments and records */
    int                   now;          /* core path: which of opened and targets is up to date */
    int                   compute;
    uint32_t             *words;        /* what was read back */
    uint32_t             *firsts;       /* the first view of the open segment of each pixel */
    cohsm_segment        *segments;     /* not private: after glbk_csm_builder_end all of them, in the order
                                           that cohsm_builder_import wants, until the builder is freed */
    size_t                segment_count;
    size_t                segment_room;
} glbk_csm_builder;

GLBK_DEF glbk_result glbk_csm_builder_create(glbk_context *ctx, const glbk_csm_builder_desc *desc,
                                             glbk_csm_builder *out);
/* Makes a builder that has drawn no view yet, which glbk_csm_builder_free takes back.
   Memory   here 84 map_side^2 bytes; on the GPU 4 layers of up to 4 MB, and 64 map_side^2 bytes
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range. GLBK_ERR_ALLOC, and
            those of textures, targets and glbk_program_compile */

GLBK_DEF glbk_result glbk_csm_builder_draw(glbk_context *ctx, glbk_csm_builder *builder, uint32_t from,
                                           uint32_t count);
/* Draws the layers of views from .. from + count - 1, calling view_fn and draw_fn once for each view and
   layer.
   count    1 .. builder->batch
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, the builder was not created, or count is 0. GLBK_ERR_LIMIT:
            count is above builder->batch. Those of glbk_begin */

GLBK_DEF glbk_result glbk_csm_builder_compress(glbk_context *ctx, glbk_csm_builder *builder);
/* Finds the segments of the views that were drawn last, which must follow those compressed before, and reads
   them back.
   Memory   12 bytes a segment
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the builder was not created. GLBK_ERR_ORDER: no views
            were drawn, others come next, or they lie on both sides of a multiple of 65,536. GLBK_ERR_ALLOC,
            and those of glbk_target_read and glbk_buffer_read */

GLBK_DEF glbk_result glbk_csm_builder_end(glbk_context *ctx, glbk_csm_builder *builder);
/* Ends the segments that are open. Call it once, after the last view: builder->segments are complete then. In
   the cohsm_stats of such a build empty_intervals and open_entries mean nothing, since csm.h does not see the
   layers.
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the builder was not created. GLBK_ERR_ORDER: no view was
            compressed. GLBK_ERR_ALLOC */

GLBK_DEF void glbk_csm_builder_free(glbk_context *ctx, glbk_csm_builder *builder);
/* Deletes the builder's objects of GL, frees its memory and zeroes the struct. NULL is allowed. */
