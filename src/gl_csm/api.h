/* ---- csm: coherent shadow maps, after csm.h ----

   Blocks of csm.h are uploaded as they are (cohsm_data), all of a scene into one table; up to 16 instances are in a
   uniform block, more in a table of their own, so that moving them leaves the blocks alone. docs/gpu-layouts.md has all
   layouts, for those who bring their own API. Then the complete renderer of the paper's section 5, whose lights,
   materials and samples are those of lightsampling.h. For shaders of your own, lib/csm_visible.glsl with glbk_csm_bind:

       cohsm_query cohsm_ask(int light, int filtering, float bias);       // COHSM_LIGHT_*, COHSM_FILTER_*; map pixels
       float csm_visible(uint entity, cohsm_query query, vec3 point, vec3 light);

   entity: the instance that the point lies on, counted from 1, or 0 for none, as in cohsm_query.entities; point:
   world; light: by COHSM_LIGHT_DIRECTION the unit direction to it, _POSITION a place, _PARAMETER coordinates in 0..1,
   _INDEX uintBitsToFloat(cell) in x. Result: 1 lit, 0 dark, between with PCF, -1 refused. Roulette: set query.seed, and
   query.id anew for each sample. */

#define GLBK_CSM_TEXTURES(X)                                                                        \
    X(usampler2DArray, glbk_csm_blocks, 0)                                                          \
    X(usampler2DArray, glbk_csm_lights, 1)      /* lights, lobes, patterns */                       \
    X(usampler2D, glbk_csm_place, 2)            /* of the G-buffer, for pictures */                 \
    X(usampler2D, glbk_csm_normal, 3)                                                               \
    X(glbk_color_sampler, glbk_csm_sum, 6)                                                          \
    X(usampler2DArray, glbk_csm_instances, 7)   /* where there are many; 8 to 11 are the G-buffer's */  \
    X(usampler2DArray, glbk_csm_questions, 5)                                                       \
    X(usampler2D, glbk_csm_layer0, 2)           /* building: depth layers of a batch of views */    \
    X(usampler2D, glbk_csm_layer1, 3)                                                               \
    X(usampler2D, glbk_csm_layer2, 4)                                                               \
    X(usampler2D, glbk_csm_opened, 5)           /* building: the open segment of each pixel */

#define GLBK_CSM_SCENE_MEMBERS(X)                                                                   \
    X(uvec4, table, 1)          /* 0; count; 1: they are in the block; 0 */                         \
    X(uvec4, instances, 176)    /* up to 16: the record, then texels 1 to 7 of the block */

#define GLBK_CSM_FRAME_MEMBERS(X)                                                                   \
    X(uvec4, light, 1)          /* texel of the light; 0; instances; ask */                         \
    X(uvec4, sampling, 1)       /* S, seed, frame, sampling */                                      \
    X(uvec4, range, 1)          /* samples from, to (resolving: corner); filter; seed of roulette */ \
    X(uvec4, tables, 1)         /* texel of the patterns; planes; width, height */                  \
    X(vec4, query, 1)           /* bias; offset; 1 / frames; 0 = the sum begins here */             \
    X(vec4, eye, 1)                                                                                 \
    X(vec4, planes, 8)

#define GLBK_CSM_PEEL_MEMBERS(X)                                                                    \
    X(mat4, view, 1)            /* object to pixels of the tile, depth or w */                      \
    X(vec4, values, 1)          /* 2 / size; depth of w = 1, or 0; open thickness */                \
    X(uvec4, tiles, 1)          /* size of a tile, tiles in a row, views */                         \
    X(uvec4, how, 1)            /* top of the grid; far; positional; self_only */

#define GLBK_CSM_BLOCKS(X)                              \
    X(glbk_csm_scene, 0, GLBK_CSM_SCENE_MEMBERS)        \
    X(glbk_csm_frame, 1, GLBK_CSM_FRAME_MEMBERS)        \
    X(glbk_csm_peel, 3, GLBK_CSM_PEEL_MEMBERS)

#define GLBK_CSM_STORAGE(X)                             \
    X(readonly, uvec4, glbk_csm_asked, 1)               \
    X(writeonly, float, glbk_csm_answers, 2)            \
    X(restrict, uvec4, glbk_csm_records, 3)

#define GLBK_CSM_IMAGES(X)      X(restrict, rgba32f, image2D, glbk_csm_total, 0)     /* the sum, by compute */

GLBK__PART(CSM)

GLBK_DEF const glbk_part *glbk_csm_part(void);
/* The GLSL of this header, for programs of your own that use its library files: glbk_source.parts. */

#define GLBK_CSM_MAX_PLANES 8u

typedef struct glbk_csm_block { const void *data; size_t bytes; } glbk_csm_block;    /* what cohsm_data returns */

typedef struct glbk_csm_instance {
    uint32_t start;             /* of its block: what glbk_csm_maps_create returned */
    float    transform[16];     /* object to world: rotation, one scale > 0, translation */
    float    offset;            /* world units that receivers on it move along their geometric normal, in the
                                   renderer */
} glbk_csm_instance;

typedef struct glbk_csm_maps {  /* read only; zeroed = none. Blocks and instances of one scene */
    glbk_texture blocks;
    glbk_buffer  scene;
    uint32_t     texels, capacity, count;       /* texels: of all blocks */
    char         defines[80];   /* what all blocks have in common, for glbk_csm_bind */
    uint32_t     key, near_count, starts[16], heads[16][28];
    glbk_texture instances;     /* none where they fit in the uniform block */
} glbk_csm_maps;

GLBK_DEF glbk_result glbk_csm_maps_create(glbk_context *ctx, const glbk_csm_block *blocks, size_t count,
                                          uint32_t capacity, uint32_t *starts, glbk_csm_maps *out);
/* Uploads blocks, bytes as they are. No more than 4 GB and ctx->max_layers layers of 16 MB; 256 are guaranteed.
   capacity   instances there is room for
   starts     receives for each block where it begins, for glbk_csm_instance
   Errors     GLBK_ERR_ARGUMENT, GLBK_ERR_FORMAT (not a block of csm.h), GLBK_ERR_VERSION, GLBK_ERR_LIMIT */

GLBK_DEF glbk_result glbk_csm_maps_place(glbk_context *ctx, glbk_csm_maps *maps, const glbk_csm_instance *instances,
                                         uint32_t count);
/* All instances of the scene, each time that one moves: one upload.
   Errors   GLBK_ERR_ARGUMENT, where a transform shears, mirrors or scales unevenly, too; GLBK_ERR_ALLOC, of many */

GLBK_DEF void glbk_csm_bind(glbk_context *ctx, const glbk_csm_maps *maps, const glbk_offset *offset);
/* For a program of yours with csm_visible among its library files, which is bound: textures and uniform block, moved by
   the offset that csm has in the program; NULL = none. One compiled with maps->defines among its own is much faster
   (one domain, one order, one orientation, no table of instances), but is for maps with the same defines only. */

GLBK_DEF void glbk_csm_maps_free(glbk_context *ctx, glbk_csm_maps *maps);

/* Answers in bulk, as cohsm_visible_scene gives them. */
#define GLBK_CSM_MAX_PROGRAMS 64u       /* combinations of ask, filter, kind of maps (and shape) that are kept
                                           compiled; then the one that was not used for longest makes room */

typedef struct glbk_csm_programs {
    glbk_program list[GLBK_CSM_MAX_PROGRAMS];
    uint32_t     keys[GLBK_CSM_MAX_PROGRAMS], count;
    uint32_t     used[GLBK_CSM_MAX_PROGRAMS], frame;    /* private: in which frame each was asked for last */
} glbk_csm_programs;

typedef struct glbk_csm_asker { /* read only; zeroed = none */
    glbk_csm_programs programs;
    uint32_t     question;      /* 1 + 3 light_kind + filter of those uploaded; 0: none */
    glbk_texture questions, answers;
    glbk_target  target;
    glbk_buffer  frame, asked, answered;    /* the latter two: compute path */
    uint32_t     capacity;
} glbk_csm_asker;

GLBK_DEF glbk_result glbk_csm_asker_create(glbk_context *ctx, uint32_t capacity, glbk_csm_asker *out);
GLBK_DEF glbk_result glbk_csm_ask_upload(glbk_context *ctx, glbk_csm_asker *asker, const cohsm_query *query);
GLBK_DEF glbk_result glbk_csm_ask_run(glbk_context *ctx, glbk_csm_asker *asker, const glbk_csm_maps *maps,
                                      uint32_t count);
GLBK_DEF glbk_result glbk_csm_ask_read(glbk_context *ctx, glbk_csm_asker *asker, uint32_t count, float *visible);
GLBK_DEF void glbk_csm_asker_free(glbk_context *ctx, glbk_csm_asker *asker);
/* create    capacity: the most questions that are uploaded at once, 1 .. 2^20
   upload    puts the points and lights of a query on the GPU; 1 .. capacity of them. With COHSM_LIGHT_PARAMETER
             light_stride must be 12 or more, and three floats are read, since the maps' dimensions are not known yet
   run       answers the first count of them; may be repeated. Compiles a program for the first maps with their defines,
             light_kind and filter. Maps that cannot answer this kind of light give what is in them: ask cohsm_visible
             once, which refuses. Errors: GLBK_ERR_ORDER without an upload, those of glbk_program_create
   read      waits and copies count floats: 1 lit, 0 dark, between with PCF, -1 refused
   Where ctx->compute, the compute path is taken, unless storage buffers may not be as large as 32 bytes a question. */

/* ---- csm: lights ---- */

/* A light is a lsamp_light_desc, and is refused where lsamp_light_init refuses it; GPUs cannot call functions, so
   LSAMP_LIGHT_CALLBACK and emission_fn are refused, too. Differences:
   - cone_half_angle of a spot may reach pi.
   - A mesh is sampled triangle by triangle, in their order, by area; lightsampling.h cuts it first. Samples and their
     coordinates are those of lsamp_sample if the mesh is made of lsamp_light_triangles, without indices. Give it those
     where the light's maps are asked by COHSM_LIGHT_PARAMETER. places and radius do not matter here. */

GLBK_DEF size_t glbk_csm_light_texels(const lsamp_light_desc *desc);
/* Texels (of 16 bytes) that a light takes in a table; 0: the desc is refused, and glbk_csm_light_write says why. Needs
   no context. */
GLBK_DEF glbk_result glbk_csm_light_write(const lsamp_light_desc *desc, uint32_t *words);
/* Writes 4 words a texel: the light as it is at desc->time. Texels of L that are not finite or negative count as 0.
   Errors   GLBK_ERR_ARGUMENT (NULL); GLBK_ERR_DESC, named in desc->system.log; GLBK_ERR_INPUT (a mesh without area) */

typedef struct glbk_csm_lights_desc {
    const lsamp_light_desc *lights;
    uint32_t          light_count;
    const lsamp_lobe *lobes;            /* of all Lafortune materials, or NULL */
    uint32_t          lobe_count;
    const float      *patterns;         /* lsamp_patterns_build, or NULL = a scrambled (0, 2)-sequence */
    uint32_t          pattern_length;   /* S; then every light must be used with S samples */
} glbk_csm_lights_desc;

typedef struct glbk_csm_lights {        /* read only; zeroed = none */
    glbk_texture texels;
    uint32_t     lobe_count, patterns_at, pattern_length;
} glbk_csm_lights;

GLBK_DEF glbk_result glbk_csm_lights_create(glbk_context *ctx, const glbk_csm_lights_desc *desc, uint32_t *starts,
                                            glbk_csm_lights *out);
/* starts   receives for each light where it begins
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_DESC, GLBK_ERR_INPUT (a mesh without area), GLBK_ERR_LIMIT, GLBK_ERR_ALLOC (all
            texels are put together in memory once). What is refused is named in the context's log */
GLBK_DEF glbk_result glbk_csm_lights_update(glbk_context *ctx, glbk_csm_lights *lights, uint32_t start,
                                            const lsamp_light_desc *desc);
/* A light that moved or changed, or whose desc->time went on: its glbk_csm_light_texels stayed the same. */
GLBK_DEF void glbk_csm_lights_free(glbk_context *ctx, glbk_csm_lights *lights);

/* ---- csm: the Monte Carlo renderer of direct light ----

   Once glbk_csm_maps_create, glbk_csm_lights_create, glbk_csm_renderer_create. A frame:

       glbk_csm_maps_place(gl, &maps, instances, n);              // where something moved, and then:
       glbk_csm_reset(&r);                                        // frames are averaged until here; camera, lights, too
       glbk_gbuffer_begin(gl, &seen, clip, eye);                  // or glbk_gbuffer_import, glbk_gbuffer_upload
       glbk_gbuffer_object(gl, &seen, &surface);                  // of each object, and your draw
       glbk_csm_render(gl, &r, &seen, &frame);
       glbk_csm_resolve(gl, &r, &seen, &pass, NULL);

   Of the G-buffer (gl_gbuffer.h) entity is the instance that a pixel lies on, plane the one of
   glbk_csm_frame_desc.planes, both counted from 1; first_lobe counts in glbk_csm_lights_desc.lobes. Occlusion is of
   bounced light and plays no part. */

typedef struct glbk_csm_renderer_desc {
    uint32_t width, height;     /* of the picture, and of its G-buffers */
    uint32_t lobes;             /* most lobes of a material: 1..8; 0 = 1 */
    int      patterns;          /* not 0: the lights have patterns */
} glbk_csm_renderer_desc;

typedef struct glbk_csm_renderer {      /* read only; zeroed = none */
    glbk_csm_programs shade;
    glbk_program resolve;
    uint32_t     lobes, patterns;
    glbk_texture sums[2];
    glbk_target  targets[2];
    glbk_buffer  frame;
    uint32_t     width, height, frames, passes, now;
    int          compute;
} glbk_csm_renderer;

GLBK_DEF glbk_result glbk_csm_renderer_create(glbk_context *ctx, const glbk_csm_renderer_desc *desc,
                                              glbk_csm_renderer *out);
GLBK_DEF void glbk_csm_renderer_free(glbk_context *ctx, glbk_csm_renderer *renderer);

typedef struct glbk_csm_use {           /* a light in a frame */
    uint32_t             start;         /* from glbk_csm_lights_create */
    lsamp_light_kind     kind;          /* of that light */
    const glbk_csm_maps *maps;          /* what its samples ask */
    cohsm_light_kind     ask;           /* and by what */
    uint32_t             samples;       /* S, 1..65536 */
    uint32_t             seed;          /* another for each light */
} glbk_csm_use;

typedef struct glbk_csm_frame_desc {
    const glbk_csm_lights *lights;
    const glbk_csm_use    *uses;
    uint32_t               use_count;
    float                  eye[3];
    float                  planes[GLBK_CSM_MAX_PLANES][4];  /* receivers without maps: unit normal, distance */
    uint32_t               plane_count;
    lsamp_sampling         sampling;
    cohsm_filter           filter;
    float                  bias;                /* as in cohsm_query: 0 = 1 pixel of a map, negative = none */
    float                  offset;              /* map pixels that receivers move, local lights; else see instances */
    uint32_t               frame;               /* of progressive rendering: other random numbers */
    uint32_t               samples_per_pass;    /* 0 = 64: a pass must not take longer than the driver's patience */
} glbk_csm_frame_desc;

GLBK_DEF glbk_result glbk_csm_render(glbk_context *ctx, glbk_csm_renderer *renderer, const glbk_gbuffer *gbuffer,
                                     const glbk_csm_frame_desc *desc);
/* Adds one frame of what the G-buffer holds to the sum. The first use of a combination of kind, ask, filter and kind of
   maps compiles a program;
   see glbk_csm_prepare. After an error some lights of the frame may be in the sum: glbk_csm_reset.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC; GLBK_ERR_MISMATCH (samples that are not the patterns' length, a
            G-buffer of another size); GLBK_ERR_LIMIT: more than GLBK_CSM_MAX_PROGRAMS combinations in one frame;
            those of glbk_program_create and glbk_buffer_update */

GLBK_DEF glbk_result glbk_csm_prepare(glbk_context *ctx, glbk_csm_renderer *renderer, const glbk_csm_frame_desc *desc);
/* Compiles what such a frame needs, so that the first one does not stutter. Errors: as glbk_csm_render */

GLBK_DEF void glbk_csm_reset(glbk_csm_renderer *renderer);
/* Forgets all frames. */

GLBK_DEF glbk_result glbk_csm_resolve(glbk_context *ctx, glbk_csm_renderer *renderer, const glbk_gbuffer *gbuffer,
                                      const glbk_pass *pass, const glbk_picture *picture);
/* Draws the mean of the frames, linear radiance, to the pass's target; viewports: see glbk_pass.
   picture   or NULL, see glbk_picture
   gbuffer   that was rendered; it may be NULL where picture does not ask what is seen, or is NULL
   Errors    GLBK_ERR_ARGUMENT; GLBK_ERR_MISMATCH: picture asks, and there is no G-buffer, or one of another size */

GLBK_DEF glbk_result glbk_csm_read(glbk_context *ctx, glbk_csm_renderer *renderer, float *rgba);
/* The mean: 4 floats a pixel; a is the mean number of samples that were refused. Waits for the GPU.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_ORDER before the first frame */

/* ---- csm: building on the GPU ----

   Draws the layers of a builder's views by depth peeling and finds their segments (equation 1). csm.h then writes the
   block: its cohsm_builder is given, for each view, layers that keep exactly the segments found here, so that the bytes
   are those which it would have built from the layers that were drawn. For views 0 .. view_count - 1, batch by batch:

       while (from < views) { glbk_csm_builder_draw(gl, &b, from, n); glbk_csm_builder_compress(gl, &b); from += n; }
       glbk_csm_builder_replay(gl, &b, add, user);              // calls cohsm_builder_add for all views

   glbk_csm_builder_layers reads what was drawn instead, for a builder that compresses on the CPU. */

typedef void (*glbk_csm_view_fn)(void *user, uint32_t index, cohsm_view *out);
/* Writes the camera of a view: cohsm_builder_view. Of its fields matrix and depth_scale are read. */
typedef void (*glbk_csm_draw_fn)(void *user, glbk_context *ctx);
/* Draws your object: bind its vertex array, attribute 0 the position in object space, and draw; program and state are
   ours. */
typedef int (*glbk_csm_add_fn)(void *user, uint32_t index, const float *z1, const float *z2, const float *z3);
/* Takes the layers of a view: cohsm_builder_add. Not 0 ends the replay. */

typedef struct glbk_csm_builder_desc {
    uint32_t         map_side;          /* M, 4..1024 */
    cohsm_layers     layers;            /* COHSM_LAYERS_Z1Z3_SPHERE is refused: it is built on the CPU only */
    uint32_t         depth_bits;        /* as in cohsm_desc; 0 = 8 */
    float            open_thickness;    /* as in cohsm_desc; 0 = 8 */
    int              positional, self_only;
    glbk_csm_view_fn view_fn;
    glbk_csm_draw_fn draw_fn;
    void            *user;              /* given to both */
} glbk_csm_builder_desc;

typedef struct glbk_csm_segment { uint32_t first, pixel, value; } glbk_csm_segment; /* private */

typedef struct glbk_csm_builder {       /* batch: most views that are drawn at once. The rest is private */
    uint32_t              batch, tiles, drawn, drawn_from, next_view, passes;
    glbk_csm_builder_desc desc;
    glbk_program          first_layer, next_layer, compress;
    glbk_texture          layers[3], depth, opened[2], records[3];
    glbk_target           layer_targets[3], targets[2];
    glbk_buffer           block, storage;
    int                   now, compute;
    uint32_t             *words;        /* what was read back */
    uint32_t             *firsts;       /* of the open segment of each pixel */
    glbk_csm_segment     *segments;
    size_t                segment_count, segment_room;
} glbk_csm_builder;

GLBK_DEF glbk_result glbk_csm_builder_create(glbk_context *ctx, const glbk_csm_builder_desc *desc,
                                             glbk_csm_builder *out);
GLBK_DEF glbk_result glbk_csm_builder_draw(glbk_context *ctx, glbk_csm_builder *builder, uint32_t from, uint32_t count);
GLBK_DEF glbk_result glbk_csm_builder_layers(glbk_context *ctx, glbk_csm_builder *builder, uint32_t view,
                                             uint32_t layer, float *depths);
GLBK_DEF glbk_result glbk_csm_builder_compress(glbk_context *ctx, glbk_csm_builder *builder);
GLBK_DEF glbk_result glbk_csm_builder_replay(glbk_context *ctx, glbk_csm_builder *builder,
                                             glbk_csm_add_fn add_fn, void *user);
GLBK_DEF void glbk_csm_builder_free(glbk_context *ctx, glbk_csm_builder *builder);
/* draw      count <= builder->batch views from view `from` on
   layers    layer 0, 1 (2 with Z1Z3) of a view from the last draw: map_side^2 depths, above 1 where there is no hit
   compress  the views drawn last, which must follow those compressed before
   replay    after the last view: add_fn for each in turn; its not 0 ends with GLBK_ERR_INPUT. Stored segments are
             those of the layers; cohsm_stats of it counts no open, empty entries
   Memory    16 map_side^2 words, 12 bytes a segment (twice in replay)
   Errors    GLBK_ERR_ARGUMENT, GLBK_ERR_DESC, GLBK_ERR_ORDER (views that were not drawn), GLBK_ERR_ALLOC */
