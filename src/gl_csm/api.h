/* ---- csm: blocks of csm.h, and instances of them ----

   The blocks of a scene, as cohsm_data returns them, are uploaded once, into one table. Instances are apart
   from them, so that moving objects leaves the blocks alone: up to 16 stand in a uniform block, more in a
   table of their own. Shaders of your own ask them by lib/csm_visible.glsl, after glbk_csm_bind:

       cohsm_query cohsm_ask(int light, int filtering, float bias);
       float csm_visible(uint entity, cohsm_query query, vec3 point, vec3 light);

   cohsm_ask takes a COHSM_LIGHT_..., a COHSM_FILTER_... and a bias in pixels of a map. csm_visible returns 1
   lit, 0 dark, something between with PCF, or -1 where the light lies inside an object's hull.

       entity   the instance that the point lies on, counted from 1; 0 = none
       point    world space
       light    COHSM_LIGHT_DIRECTION: the unit direction to it; _POSITION: a place in world space;
                _PARAMETER: its coordinates 0..1; _INDEX: the cell, as uintBitsToFloat(cell) in x

   With COHSM_FILTER_ROULETTE also set query.seed, and query.id to another number for each sample.
   docs/gpu-layouts.md has all layouts, for those who bring their own API. */

GLBK_DEF const glbk_part *glbk_csm_part(void);
/* Returns the GLSL of this header, for glbk_source.parts of a program of yours that uses its library
   files. */

typedef struct glbk_csm_block {     /* one object's maps: what cohsm_data returns */
    const void *data;
    size_t      bytes;
} glbk_csm_block;

typedef struct glbk_csm_instance {
    uint32_t start;                 /* says which block: what glbk_csm_maps_create wrote for it */
    float    transform[16];         /* object to world, column-major: a rotation, one scale > 0, a
                                       translation */
    float    offset;                /* how far the renderer moves receivers on it along their geometric
                                       normal, world units, lest they shadow themselves */
} glbk_csm_instance;

typedef struct glbk_csm_maps {      /* blocks and instances of one scene; read only; zeroed = none */
    glbk_texture blocks;            /* the table of all blocks */
    glbk_texture instances;         /* the table of instances; none where they fit into the uniform block */
    glbk_buffer  scene;             /* the uniform block */
    uint32_t     texels;            /* of all blocks */
    uint32_t     capacity;          /* the most instances */
    uint32_t     count;             /* instances that are placed */
    char         defines[80];       /* what all blocks have in common, for programs of your own: see
                                       glbk_csm_bind */
    uint32_t     key;               /* private, like all that follows: a number for defines */
    uint32_t     near_count;        /* instances that the uniform block has room for, 0 = they are in the
                                       table */
    uint32_t     starts[16];        /* of the first blocks */
    uint32_t     heads[16][28];     /* texels 1 to 7 of the first blocks */
} glbk_csm_maps;

GLBK_DEF glbk_result glbk_csm_maps_create(glbk_context *ctx, const glbk_csm_block *blocks, size_t count,
                                          uint32_t capacity, uint32_t *starts, glbk_csm_maps *out);
/* Uploads blocks, their bytes as they are, and makes room for instances, none of which is placed yet.
   blocks     count of them; they are read during the call only
   capacity   the most instances that are ever placed, up to 2^26
   starts     receives for each block where it begins, for glbk_csm_instance.start
   Memory     on the GPU the bytes of all blocks, and 64 bytes an instance beyond 16
   Errors     GLBK_ERR_ARGUMENT; GLBK_ERR_FORMAT: not a block of csm.h, or a damaged one; GLBK_ERR_VERSION;
              GLBK_ERR_LIMIT: more than 4 GB, or than ctx->max_layers layers of 16 MB, of which GL guarantees
              256; those of textures and buffers */

GLBK_DEF glbk_result glbk_csm_maps_place(glbk_context *ctx, glbk_csm_maps *maps,
                                         const glbk_csm_instance *instances, uint32_t count);
/* Replaces all instances of the scene. Call it whenever one of them has moved: it is one upload, of 64 bytes
   an instance (3 KB where there are no more than 16).
   count    0 .. maps->capacity
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, count is too large, a start is none of these maps', or a
            transform shears, mirrors or scales unevenly; GLBK_ERR_ALLOC, with more than 16 instances */

GLBK_DEF void glbk_csm_bind(glbk_context *ctx, const glbk_csm_maps *maps, const glbk_offset *offset);
/* Binds textures and uniform block of the maps for a program of yours that uses lib/csm_visible.glsl and is
   bound (glbk_begin). A program that was compiled with maps->defines among its own is much faster, since it
   holds the code of one domain, one order and one orientation, but it is right for maps with the same defines
   only.
   offset   what glbk_source.offsets gives this part in the program; NULL = none */

GLBK_DEF void glbk_csm_maps_free(glbk_context *ctx, glbk_csm_maps *maps);
/* Deletes the maps' objects of GL and zeroes the struct. Accepts NULL. */

/* ---- csm: programs that are kept ---- */

#define GLBK_CSM_MAX_PROGRAMS                                                                                \
    64u /* combinations of light_kind, filter, defines of maps and shape of lights that are
                                       kept compiled; then the one that was not used for longest makes room */

typedef struct glbk_csm_programs {  /* private */
    glbk_program list[GLBK_CSM_MAX_PROGRAMS];
    uint32_t     keys[GLBK_CSM_MAX_PROGRAMS];   /* the combination of each */
    uint32_t     used[GLBK_CSM_MAX_PROGRAMS];   /* the frame in which each was asked for last */
    uint32_t     count;
    uint32_t     frame;
} glbk_csm_programs;

/* ---- csm: many questions at once ----

   An asker answers queries of points and lights in bulk, as cohsm_visible_scene does. Where ctx->compute, it
   uses storage buffers, unless they may not be as large as 32 bytes a question; else a pass draws the answers
   into a texture. */

typedef struct glbk_csm_asker {     /* read only; zeroed = none */
    glbk_csm_programs programs;
    uint32_t     capacity;          /* the most questions */
    uint32_t     question;          /* private: 1 + 3 light_kind + filter of those uploaded; 0 = none */
    glbk_texture questions;         /* core path: questions and answers, the answers as the bits of floats,
                                       question i at (i & 1023, i >> 10) */
    glbk_texture answers;
    glbk_target  target;            /* private */
    glbk_buffer  frame;             /* private */
    glbk_buffer  asked;             /* compute path: questions and answers, a float each */
    glbk_buffer  answered;
} glbk_csm_asker;

GLBK_DEF glbk_result glbk_csm_asker_create(glbk_context *ctx, uint32_t capacity, glbk_csm_asker *out);
/* Makes room on the GPU for questions and their answers.
   capacity   the most questions at once, 1..2^20
   Memory     36 bytes a question
   Errors     GLBK_ERR_ARGUMENT: a pointer is NULL or capacity is out of range; those of textures and buffers
              */

GLBK_DEF glbk_result glbk_csm_ask_upload(glbk_context *ctx, glbk_csm_asker *asker, const cohsm_query *query);
/* Uploads the points and lights of a query, 1 .. capacity of them. With COHSM_LIGHT_PARAMETER light_stride
   must be 12 or more, and three floats are read for each light, since the dimensions of the maps are not
   known yet.
   Memory   32 bytes a question while it runs
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, a count or stride is out of range; GLBK_ERR_DESC:
            light_kind, filter or bias; GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_csm_ask_run(glbk_context *ctx, glbk_csm_asker *asker, const glbk_csm_maps *maps,
                                      uint32_t count);
/* Answers the first questions of those uploaded, on the GPU; it may be repeated, with other maps too. It
   compiles a program for the first maps with their defines, light_kind and filter. Maps that cannot answer
   this kind of light give numbers without a meaning: ask cohsm_visible with the same query once, which
   refuses then.
   count    1 .. asker->capacity
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_ORDER: nothing was uploaded yet; those of glbk_program_compile */

GLBK_DEF glbk_result glbk_csm_ask_read(glbk_context *ctx, glbk_csm_asker *asker, uint32_t count,
                                       float *visible);
/* Waits for the GPU and copies the first answers: 1 lit, 0 dark, something between with PCF, -1 where the
   light lies inside an object's hull.
   visible   receives count floats, count being 1 .. asker->capacity
   Errors    GLBK_ERR_ARGUMENT; those of glbk_buffer_read and glbk_target_read */

GLBK_DEF void glbk_csm_asker_free(glbk_context *ctx, glbk_csm_asker *asker);
/* Deletes the asker's objects of GL and zeroes the struct. Accepts NULL. */

/* ---- csm: lights ----

   A light is a lsamp_light_desc, and is refused where lsamp_light_init refuses it. These are the differences:

   - GPUs cannot call functions, so LSAMP_LIGHT_CALLBACK and emission_fn are refused, too.
   - cone_half_angle of a spot may reach pi.
   - A mesh is sampled triangle by triangle, in their order, by area; lightsampling.h cuts it first, and its
     places and
   radius do not matter here. Samples and their coordinates are those of lsamp_sample if the mesh is made of
   lsamp_light_triangles, without indices: give it those where the light's maps are asked by
   COHSM_LIGHT_PARAMETER.
   - Texels of L that are not finite or negative count as 0. */

typedef struct glbk_csm_lights_desc {
    const lsamp_light_desc *lights;
    uint32_t                light_count;
    const lsamp_lobe       *lobes;          /* of all Lafortune materials one after the other; NULL = none */
    uint32_t                lobe_count;     /* up to 2^20 */
    const float            *patterns;       /* from lsamp_patterns_build; NULL = a scrambled (0,
                                               2)-sequence */
    uint32_t                pattern_length; /* S, 1..65536 with patterns, else 0; every light of a frame must
                                               then have S samples */
} glbk_csm_lights_desc;

typedef struct glbk_csm_lights {    /* a table of lights; read only; zeroed = none */
    glbk_texture texels;
    uint32_t     lobe_count;
    uint32_t     patterns_at;       /* texel of the first pattern */
    uint32_t     pattern_length;
} glbk_csm_lights;

GLBK_DEF glbk_result glbk_csm_lights_create(glbk_context *ctx, const glbk_csm_lights_desc *desc,
                                            uint32_t *starts, glbk_csm_lights *out);
/* Uploads lights as they are at their desc.time, lobes and patterns.
   starts   receives for each light where it begins, for glbk_csm_use.start
   Memory   16 bytes a texel, on the GPU and here while it runs: 2 texels a lobe, 10 a light, 2 more for each
            texel of its L, 3 a triangle, 128 for each point of a pattern
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, and the log names the field; GLBK_ERR_INPUT: a mesh without
            area; GLBK_ERR_LIMIT: more than 2^28 texels; GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_csm_lights_update(glbk_context *ctx, glbk_csm_lights *lights, uint32_t start,
                                            const lsamp_light_desc *desc);
/* Replaces a light that has moved or changed, or whose desc->time went on. Its texture has the size that it
   had, and its mesh as many triangles.
   start    what glbk_csm_lights_create wrote for it
   Errors   as for glbk_csm_lights_create; GLBK_ERR_ARGUMENT where start is that of no light with as many
            texels */

GLBK_DEF void glbk_csm_lights_free(glbk_context *ctx, glbk_csm_lights *lights);
/* Deletes the table and zeroes the struct. Accepts NULL. */

/* The next two need no context. They serve renderers on another API, whose shaders have lib/cohsm_light.glsl
   or a translation of it: examples/06b_csm_own_api.c. */

GLBK_DEF size_t glbk_csm_light_texels(const lsamp_light_desc *desc);
/* Returns how many texels, of 16 bytes each, a light takes in a table, or 0 if it is refused or desc is
   NULL. */

GLBK_DEF glbk_result glbk_csm_light_write(const lsamp_light_desc *desc, uint32_t *words);
/* Writes a light as it stands in a table, at desc->time; docs/gpu-layouts.md has the layout.
   words    receives 4 words for each of glbk_csm_light_texels(desc) texels
   Errors   GLBK_ERR_ARGUMENT: NULL; GLBK_ERR_DESC, and desc->system.log is told the field; GLBK_ERR_INPUT: a
            mesh without area */

/* ---- csm: the Monte Carlo renderer of direct light ----

   A program calls glbk_csm_maps_create, glbk_csm_lights_create and glbk_csm_renderer_create once. A frame:

       glbk_csm_maps_place(gl, &maps, instances, n);              // where an object has moved, and then
       glbk_csm_reset(&r);                                        // this, as where the camera or a light has
       glbk_gbuffer_begin(gl, &seen, clip, eye);                // or glbk_gbuffer_import, glbk_gbuffer_upload
       glbk_gbuffer_object(gl, &seen, &surface);                  // for each object, with your draw
       glbk_csm_render(gl, &r, &seen, &frame);
       glbk_csm_resolve(gl, &r, &seen, &pass, NULL);

   In the G-buffer (gl_gbuffer.h) entity is the instance that a pixel lies on and plane the one of
   glbk_csm_frame_desc.planes, both counted from 1; first_lobe counts in glbk_csm_lights_desc.lobes.
   Occlusion, which is of bounced light, plays no part. */

#define GLBK_CSM_MAX_PLANES 8u

typedef struct glbk_csm_renderer_desc {
    uint32_t width;             /* pixels of the picture and of its G-buffers, 1 .. ctx->max_side */
    uint32_t height;
    uint32_t lobe_count;        /* the most lobes of a material, 1..8; 0 = 1 */
    int      patterns;          /* not 0: lights are sampled by patterns, which their table must have */
} glbk_csm_renderer_desc;

typedef struct glbk_csm_renderer {      /* read only; zeroed = none */
    glbk_csm_programs shade;            /* private */
    glbk_program resolve;               /* private */
    uint32_t     lobe_count;            /* of the desc, like patterns, width and height */
    uint32_t     patterns;
    uint32_t     width;
    uint32_t     height;
    glbk_texture sums[2];               /* sums[now]: the sum of all frames, GLBK_FORMAT_COLOR */
    glbk_target  targets[2];            /* private */
    glbk_buffer  frame;                 /* private */
    uint32_t     frames;                /* in the sum */
    uint32_t     passes;                /* 0: the sum has no pass yet */
    uint32_t     now;
    int          compute;               /* not 0: it renders by compute shaders */
} glbk_csm_renderer;

GLBK_DEF glbk_result glbk_csm_renderer_create(glbk_context *ctx, const glbk_csm_renderer_desc *desc,
                                              glbk_csm_renderer *out);
/* Makes a renderer without frames. Programs that shade are compiled when they are first used: see
   glbk_csm_prepare.
   Memory   on the GPU 32 bytes a pixel, 16 where it computes
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC: a number is out of range; those of textures, targets and
            glbk_program_compile */

GLBK_DEF void glbk_csm_renderer_free(glbk_context *ctx, glbk_csm_renderer *renderer);
/* Deletes the renderer's objects of GL and zeroes the struct. Accepts NULL. */

typedef struct glbk_csm_use {           /* a light in a frame */
    uint32_t             start;         /* which light: what glbk_csm_lights_create wrote for it */
    lsamp_light_kind     kind;          /* of that light */
    const glbk_csm_maps *maps;          /* the maps that its samples ask */
    cohsm_light_kind     ask;           /* by what they ask: direction, position, parameter or index */
    uint32_t             sample_count;  /* S, samples a pixel and frame, 1..65536 */
    uint32_t             seed;          /* of its random numbers; give each light another one */
} glbk_csm_use;

typedef struct glbk_csm_frame_desc {
    const glbk_csm_lights *lights;
    const glbk_csm_use    *uses;        /* the lights that shine in this frame */
    uint32_t               use_count;
    float                  eye[3];      /* world */
    float                  planes[GLBK_CSM_MAX_PLANES][4];  /* infinite planes that receive light, have no
                                                               maps and hide what lies behind them: unit
                                                               normal, distance from the origin along it */
    uint32_t               plane_count; /* 0..GLBK_CSM_MAX_PLANES */
    lsamp_sampling         sampling;
    cohsm_filter           filter;
    float                  bias;        /* as in cohsm_query: 0 = 1 pixel of a map, negative = none */
    float                  offset;      /* pixels of a map that receivers of local lights move along their
                                           geometric normal, >= 0; those of other lights move by
                                           glbk_csm_instance.offset */
    uint32_t               frame;       /* number of the frame in progressive rendering: each has random
                                           numbers of its own */
    uint32_t               samples_per_pass;    /* samples that one draw takes, lest it outlast the driver's
                                                   patience; 0 = 64 */
} glbk_csm_frame_desc;

GLBK_DEF glbk_result glbk_csm_render(glbk_context *ctx, glbk_csm_renderer *renderer,
                                     const glbk_gbuffer *gbuffer, const glbk_csm_frame_desc *desc);
/* Adds one frame of what the G-buffer holds to the sum: for each use samples / samples_per_pass passes. The
   first use of a combination of kind, ask, filter and defines of maps compiles a program (glbk_csm_prepare).
   After an error the sum may have some lights of the frame: call glbk_csm_reset.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, and the log names the field; GLBK_ERR_MISMATCH: samples are not
            the patterns' length, or the G-buffer has another size; GLBK_ERR_LIMIT: more than
            GLBK_CSM_MAX_PROGRAMS combinations in one frame; those of glbk_program_compile and
            glbk_buffer_update */

GLBK_DEF glbk_result glbk_csm_prepare(glbk_context *ctx, glbk_csm_renderer *renderer,
                                      const glbk_csm_frame_desc *desc);
/* Compiles the programs that such a frame needs, so that the first one does not stutter.
   Errors   those of glbk_csm_render that are not about the G-buffer */

GLBK_DEF void glbk_csm_reset(glbk_csm_renderer *renderer);
/* Forgets all frames: the next one begins the sum. */

GLBK_DEF glbk_result glbk_csm_resolve(glbk_context *ctx, glbk_csm_renderer *renderer,
                                      const glbk_gbuffer *gbuffer, const glbk_pass *pass,
                                      const glbk_picture *picture);
/* Draws the mean of the frames, linear radiance, to the pass's target, a pixel each; glbk_pass says how
   viewports cut it.
   gbuffer   the one that was rendered; it may be NULL where picture does not ask what is seen
   picture   may be NULL: every pixel is drawn, without depths
   Errors    GLBK_ERR_ARGUMENT; GLBK_ERR_MISMATCH: picture asks what is seen, and there is no G-buffer, or it
             has another size; those of glbk_begin */

GLBK_DEF glbk_result glbk_csm_read(glbk_context *ctx, glbk_csm_renderer *renderer, float *rgba);
/* Waits for the GPU and reads the mean of the frames.
   rgba     receives 4 floats a pixel, rows from the bottom up: linear radiance, and how many samples of a
            frame were refused, because their light lies inside a hull
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_ORDER: there is no frame yet; those of glbk_target_read */

/* ---- csm: building on the GPU ----

   A builder of this header draws the layers of views by depth peeling and finds their segments (equation 1).
   csm.h then writes the block: its cohsm_builder is given layers for each view that keep exactly these
   segments, so that the bytes are those which it would have made of the layers that were drawn. Views come in
   batches:

       for (from = 0; from < view_count; from += n) {              // n <= b.batch
           glbk_csm_builder_draw(gl, &b, from, n);
           glbk_csm_builder_compress(gl, &b);
       }
       glbk_csm_builder_replay(gl, &b, add, user);                 // add calls cohsm_builder_add */

typedef void (*glbk_csm_view_fn)(void *user, uint32_t index, cohsm_view *out);
/* Writes the camera of a view, as cohsm_builder_view does. Of its fields matrix and depth_scale are read. */

typedef void (*glbk_csm_draw_fn)(void *user, glbk_context *ctx);
/* Draws your object: it binds a vertex array whose attribute 0 is the position in object space, and draws. It
   changes neither program nor state. */

typedef int (*glbk_csm_add_fn)(void *user, uint32_t index, const float *z1, const float *z2, const float *z3);
/* Takes the layers of a view, as cohsm_builder_add does. A result other than 0 ends the replay. */

typedef struct glbk_csm_builder_desc {
    uint32_t         map_side;          /* M, pixels, 4..1024 */
    cohsm_layers     layers;            /* COHSM_LAYERS_Z1Z3_SPHERE is refused: csm.h alone builds it */
    uint32_t         depth_bits;        /* as in cohsm_desc; 0 = 8 */
    float            open_thickness;    /* as in cohsm_desc; 0 = 8 */
    int              positional;        /* not 0: views are perspective, maps are of positions */
    int              self_only;         /* as in cohsm_desc */
    glbk_csm_view_fn view_fn;           /* required, like draw_fn */
    glbk_csm_draw_fn draw_fn;
    void            *user;              /* given to both */
} glbk_csm_builder_desc;

typedef struct glbk_csm_segment {       /* private: of one pixel */
    uint32_t first;                     /* the view that it begins with */
    uint32_t pixel;
    uint32_t value;                     /* lo | hi << 8 on the grid of depths, or an exact depth | 1 << 16 */
} glbk_csm_segment;

typedef struct glbk_csm_builder {       /* read only; zeroed = none */
    uint32_t              batch;        /* the most views that are drawn at once, a power of two */
    uint32_t              tiles;        /* private, like all that follows: tiles in a row of the atlas */
    uint32_t              drawn;        /* views that glbk_csm_builder_draw drew last */
    uint32_t              drawn_from;   /* the first of them */
    uint32_t              next_view;    /* the first that is not compressed yet */
    uint32_t              passes;       /* runs of the shader that compresses */
    glbk_csm_builder_desc desc;
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
    glbk_csm_segment     *segments;
    size_t                segment_count;
    size_t                segment_room;
} glbk_csm_builder;

GLBK_DEF glbk_result glbk_csm_builder_create(glbk_context *ctx, const glbk_csm_builder_desc *desc,
                                             glbk_csm_builder *out);
/* Makes a builder that has drawn no view yet.
   Memory   here 84 map_side^2 bytes; on the GPU 4 layers of up to 4 MB, and 64 map_side^2 bytes
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, and the log names the field; GLBK_ERR_ALLOC; those of textures,
            targets and glbk_program_compile */

GLBK_DEF glbk_result glbk_csm_builder_draw(glbk_context *ctx, glbk_csm_builder *builder, uint32_t from,
                                           uint32_t count);
/* Draws the layers of views from .. from + count - 1, calling view_fn and draw_fn once for each view and
   layer.
   count    1 .. builder->batch
   Errors   GLBK_ERR_ARGUMENT; those of glbk_begin */

GLBK_DEF glbk_result glbk_csm_builder_compress(glbk_context *ctx, glbk_csm_builder *builder);
/* Finds the segments of the views that were drawn last, which must follow those compressed before, and reads
   them back.
   Memory   12 bytes a segment
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_ORDER: no views were drawn, others come next, or they lie on both
            sides of a multiple of 65,536; GLBK_ERR_ALLOC; those of reading */

GLBK_DEF glbk_result glbk_csm_builder_replay(glbk_context *ctx, glbk_csm_builder *builder,
                                             glbk_csm_add_fn add_fn, void *user);
/* Gives layers of all compressed views to add_fn, one view after the other. Call it once, after the last
   view. Of the cohsm_stats of such a build only the count of open, empty entries is missing.
   Memory   12 bytes a segment more, 8 bytes a view and 12 map_side^2 bytes while it runs
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_ORDER: no view was compressed; GLBK_ERR_INPUT: add_fn returned
            something other than 0; GLBK_ERR_ALLOC */

GLBK_DEF void glbk_csm_builder_free(glbk_context *ctx, glbk_csm_builder *builder);
/* Deletes the builder's objects of GL, frees its memory and zeroes the struct. Accepts NULL. */
