/* ---- rsm: reflective shadow maps, after rsm.h ----

   Lights, descs and their defaults are rsm.h's, the filter's are gifilter.h's: the same struct gives the same light
   here and there. Fields that GL cannot honour are errors that name them (GLBK_ERR_DESC): desc.system and desc.add,
   which have to be zero, rsm_interpolation.mask and gifilt_frame.motion, which have to be NULL.
   Maps come from the CPU (rsm_map_texels, as they are) or are drawn here, by calls of yours; pixel lights are picked by
   flux from running sums that are made here too. A frame:

       glbk_rsm_map_draw(gl, &r, &map, draw, user);               // or glbk_rsm_map_upload
       glbk_gbuffer_begin(gl, &seen, view, eye); ...              // what the camera sees: gl_gbuffer.h
       glbk_rsm_direct(gl, &r, &seen, maps, n, &direct);          // light itself, shadowed by the same maps
       glbk_rsm_gather(gl, &r, &seen, maps, n, &gather);          // bounced light; or glbk_rsm_interpolate
       glbk_rsm_denoise(gl, &r, &seen, &frame, NULL);             // where few samples were taken
       glbk_rsm_resolve(gl, &r, &seen, &pass, NULL, 1, 1);

   All images are RGBA32UI, bits of floats, so that everything works without EXT_color_buffer_float. For shaders of your
   own, lib/rsm_direct.glsl and lib/rsm_gather.glsl with glbk_rsm_bind:

       rsm_light rsm_bound();                                             // the light whose map is bound
       vec3 rsm_direct(rsm_light l, vec3 p, vec3 n, int taps, float bias, float slope_bias);   // irradiance, W/m^2
       vec3 rsm_gather_list(rsm_light l, vec3 p, vec3 n, uint from, uint to, bool glossy, float mixed);
       vec3 rsm_gather_about(rsm_light l, vec3 p, vec3 n, float r_max, vec2 turn, uint first, uint step, uint count,
                             vec4 limits, bool glossy, float mixed, float picked, float near_field);

   World space, unit normals. The latter two give pi times bounced irradiance: by lights from .. to - 1 of the list
   (glbk_rsm_frame.range.x and .y; glossy glbk_rsm_frame.pick.w != 0u; mixed glbk_rsm_frame.pattern.y), and by points
   first, first + step, ... of the tables about p (turn: cosine and sine; limits glbk_rsm_frame.limits; picked
   glbk_rsm_frame.pattern.z). */

#define GLBK_RSM_TEXTURES(X)                                                                        \
    X(usampler2DArray, glbk_rsm_texels, 0)      /* a map: layers 3 face + 0 place, 1 normal, 2 flux */ \
    X(usampler2DArray, glbk_rsm_sums, 1)                                                            \
    X(usampler2DArray, glbk_rsm_rows, 2)                                                            \
    X(usampler2DArray, glbk_rsm_lights, 3)      /* the list of pixel lights */                      \
    X(sampler2D, glbk_rsm_pattern, 4)                                                               \
    X(sampler2D, glbk_rsm_noise, 5)                                                                 \
    X(sampler2D, glbk_rsm_materials, 6)                                                             \
    X(glbk_color_sampler, glbk_rsm_sum, 7)      /* 8 to 11: the G-buffer */                         \
    X(glbk_color_sampler, glbk_rsm_states, 12)  /* the picture while it is interpolated */          \
    X(glbk_color_sampler, glbk_rsm_coarse, 13)  /* a grid of samples */                             \
    X(glbk_color_sampler, glbk_rsm_history, 14)                                                     \
    X(usampler2DArray, glbk_rsm_before, 15)     /* place and normal of the last frame */            \
    X(sampler2D, glbk_rsm_motion, 1)            /* of programs that read no map */                  \
    X(sampler2D, glbk_rsm_albedo_map, 2)

#define GLBK_RSM_LIGHT_MEMBERS(X)                                                                   \
    X(vec4, position, 1)        /* w: half a side of the map (sun) or its tangent */                \
    X(vec4, right, 1)           /* w: kind */                                                       \
    X(vec4, up, 1)              /* w: faces */                                                      \
    X(vec4, axis, 1)            /* w: cosine of half the cone */                                    \
    X(vec4, value, 1)           /* w: texels a side */

#define GLBK_RSM_FRAME_MEMBERS(X)                                                                   \
    X(uvec4, counts, 1)         /* taps; interleave; points about the receiver; side of the noise */ \
    X(uvec4, range, 1)          /* of the list: from, to, room of a set; not 0: add. Resolving: corner */ \
    X(uvec4, pick, 1)           /* seed, lights of the map, first run, materials; of a scan: layer, stride */ \
    X(uvec4, grid, 1)           /* step, that of the grid before (compute: the finest), width, height */ \
    X(uvec4, mode, 1)                                                                               \
    X(vec4, pattern, 1)         /* r_max; scale and lights of MIXED; frames of the filter, reach */ \
    X(vec4, limits, 1)          /* offset, clamp, near_limit, sets; direct: bias, slope bias */     \
    X(vec4, tests, 1)           /* normal_cosine, plane_slope, distance, contrast */            \
    X(uvec4, lists, 1)          /* of compute: read, for open pixels, for wanted nodes; step of the next grid */ \
    X(vec4, surfaces, 1)        /* near_field */

#define GLBK_RSM_DRAWN_MEMBERS(X)                                                                  \
    X(mat4, world, 1)                                                                               \
    X(mat4, clip, 1)                                                                                \
    X(vec4, albedo, 1)          /* w: cut-off of the map's alpha */                                 \
    X(vec4, eye, 1)             /* w = 0: a direction */                                            \
    X(vec4, range, 1)           /* of depth: nearest, 1 / extent */                                 \
    X(uvec4, kinds, 1)          /* material, has a map, face */

#define GLBK_RSM_BLOCKS(X)                              \
    X(glbk_rsm_light, 0, GLBK_RSM_LIGHT_MEMBERS)        \
    X(glbk_rsm_frame, 1, GLBK_RSM_FRAME_MEMBERS)        \
    X(glbk_rsm_drawn, 2, GLBK_RSM_DRAWN_MEMBERS)

#define GLBK_RSM_STORAGE(X)                                                                         \
    X(coherent, uint, glbk_rsm_counts, 0)   /* of each list 4: groups x, y, 1; pixels */            \
    X(readonly, uint, glbk_rsm_items, 1)    /* a list: x | y << 16 */                               \
    X(writeonly, uint, glbk_rsm_left, 2)                                                            \
    X(writeonly, uint, glbk_rsm_wanted, 3)                                                          \
    X(coherent, uint, glbk_rsm_marks, 4)    /* a bit a node of the finest grid */

#define GLBK_RSM_IMAGES(X)                                                                          \
    X(restrict, rgba32f, image2D, glbk_rsm_picture, 0)                                              \
    X(restrict, rgba32f, image2D, glbk_rsm_nodes, 1)    /* of the finest grid and all before it */  \
    X(restrict writeonly, r32ui, uimage2DArray, glbk_rsm_running, 2)

GLBK__PART(RSM)

GLBK_DEF const glbk_part *glbk_rsm_part(void);
/* The GLSL of this header, for programs of your own that use its library files: glbk_source.parts. */

typedef struct glbk_rsm_map {           /* read only; zeroed = none */
    uint32_t       side, face_count;    /* 1, 5 or 6 faces */
    rsm_light      light;               /* with its defaults */
    glbk_rsm_light block;
    glbk_buffer    buffer;              /* of the block */
    glbk_texture   texels, depth, sums[2], rows[2];
    glbk_target    face_targets[6], sum_targets[2][6], row_targets[2][6];
    int            summed, sums_at, rows_at;
} glbk_rsm_map;

GLBK_DEF glbk_result glbk_rsm_map_create(glbk_context *ctx, const rsm_light *light, uint32_t side,
                                         glbk_rsm_map *out);
/* An empty map of the light. side: texels a side of each face, 4..4096; 0 = 512, cubes 256. 60 bytes a texel.
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_DESC (what rsm_map_create refuses), GLBK_ERR_LIMIT */
GLBK_DEF glbk_result glbk_rsm_map_place(glbk_context *ctx, glbk_rsm_map *map, const rsm_light *light);
/* The light moved or changed; faces stay as many. Draw or upload anew afterwards.
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_DESC, GLBK_ERR_MISMATCH (another number of faces) */
GLBK_DEF glbk_result glbk_rsm_map_upload(glbk_context *ctx, glbk_rsm_map *map, const rsm_texel *texels);
/* rsm_map_texels of a map of the same light and side: face_count x side x side. Errors: GLBK_ERR_ALLOC */
GLBK_DEF glbk_result glbk_rsm_map_read(glbk_context *ctx, const glbk_rsm_map *map, uint32_t face,
                                       rsm_texel *texels);
/* One face in that form, side x side texels. Waits for the GPU. Errors: GLBK_ERR_ALLOC */
GLBK_DEF void glbk_rsm_map_matrix(const glbk_rsm_map *map, uint32_t face, float world_to_clip[16]);
GLBK_DEF void glbk_rsm_map_free(glbk_context *ctx, glbk_rsm_map *map);

typedef struct glbk_rsm_renderer_desc {
    uint32_t width, height;
    int      interpolate, denoise;      /* not 0: memory for glbk_rsm_interpolate, for glbk_rsm_denoise */
    uint32_t lights_per_pass;           /* pixel lights that one pass adds up, at most 32768: a pass must not outlast
                                           the driver's patience. 0 = 4096 */
} glbk_rsm_renderer_desc;

#define GLBK_RSM_PROGRAM_COUNT 24u

typedef struct glbk_rsm_renderer {      /* read only; zeroed = none */
    glbk_program programs[GLBK_RSM_PROGRAM_COUNT];  /* compiled when first needed */
    glbk_texture sums[3], grids[3], history[2], kept[2], lights;     /* kept: what was seen with a history */
    glbk_target  targets[3], grid_targets[3], history_targets[2], lights_target;
    glbk_texture pattern, noise, materials;
    rsm_gather_desc tables;             /* what the three are made of, without its pointers */
    uint32_t     point_count, noise_side, material_count;
    glbk_buffer  frame, object;
    glbk_rsm_frame values;
    glbk_rsm_drawn drawn;
    float        before[16];
    uint32_t     width, height, lights_per_pass, direct, bounce, remembers;
    int          has_before, drawing, filtered;
    glbk_result  failed;                /* first of glbk_rsm_object while drawing */
    int          compute;               /* gathering and filtering dispatch: ctx->compute when it was made */
    glbk_buffer  counts, open[2], wanted, marks;        /* then, with interpolate: lists of pixels */
} glbk_rsm_renderer;

GLBK_DEF glbk_result glbk_rsm_renderer_create(glbk_context *ctx, const glbk_rsm_renderer_desc *desc,
                                              glbk_rsm_renderer *out);
/* Memory on the GPU: 4 MB, and 48 bytes a pixel, with interpolate 13 more, with denoise 96 more.
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_DESC, GLBK_ERR_LIMIT */
GLBK_DEF void glbk_rsm_renderer_free(glbk_context *ctx, glbk_rsm_renderer *renderer);

GLBK_DEF uint32_t glbk_rsm_point_count(const rsm_gather_desc *desc);
/* Returns how many points the pattern of a desc needs: 0 with RSM_PATTERN_FLUX or samples 0, and for NULL. */
GLBK_DEF glbk_result glbk_rsm_tables_upload(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                            const rsm_gather_desc *desc, const float *points);
/* What glbk_rsm_gather and _interpolate need of a desc as textures: its noise, its materials, and the points of its
   pattern. Not needed for a desc without noise, materials and points; else again wherever these, pattern, samples,
   interleave, r_min, paper_weights or seed change. Replaces all three.
   desc     at most 1024 materials, noise_side at most 1024; NULL = all defaults: no tables
   points   3 floats each, from rsm_pattern_build(pattern, glbk_rsm_point_count(desc), r_min, paper_weights, seed, ..)
            of the desc; with RSM_PATTERN_MIXED from RSM_PATTERN_LOG_RADIAL and r_min 1 / 192. NULL where the count is 0
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_DESC, GLBK_ERR_LIMIT, GLBK_ERR_ALLOC */

typedef void (*glbk_rsm_draw_fn)(void *user, glbk_context *ctx, glbk_rsm_renderer *renderer);
/* Your scene: for each object glbk_rsm_object, then a draw with attributes 0 position, 1 normal, 2 texture coordinates
   from your vertex array. An attribute that is not enabled must be zero; normals of zero are those of the triangles. */

GLBK_DEF glbk_result glbk_rsm_object(glbk_context *ctx, glbk_rsm_renderer *renderer, const glbk_surface *surface,
                                     uint32_t material);
/* Only from within a glbk_rsm_draw_fn. Its first error is what the call that draws returns, too.
   surface   as for glbk_gbuffer_object; a map takes its world, its diffuse colour (metal-rough: times 1 - metallic),
             color_map, alpha and alpha_cutoff, which the map's alpha at full size is compared with. Use
             GLBK_SAMPLING_MIPMAPS: flux is filtered then (section 6)
   material  of its texels: number of a Phong lobe in rsm_gather_desc.materials, from 1; 0 = none
   Errors    GLBK_ERR_ARGUMENT, GLBK_ERR_ORDER */

GLBK_DEF glbk_result glbk_rsm_map_draw(glbk_context *ctx, glbk_rsm_renderer *renderer, glbk_rsm_map *map,
                                       glbk_rsm_draw_fn draw_fn, void *user);
/* Calls draw_fn once a face. Both sides of triangles, normals turned to the light. */
GLBK_DEF glbk_result glbk_rsm_direct(glbk_context *ctx, glbk_rsm_renderer *renderer, const glbk_gbuffer *seen,
                                     const glbk_rsm_map *const *maps, uint32_t map_count, const rsm_direct_desc *desc);
/* Light of all maps themselves, each shadowed by its own. desc NULL = all defaults.
   seen     of the renderer's size, here and below
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_DESC, GLBK_ERR_MISMATCH (a G-buffer of another size) */

GLBK_DEF glbk_result glbk_rsm_gather(glbk_context *ctx, glbk_rsm_renderer *renderer, const glbk_gbuffer *seen,
                                     glbk_rsm_map *const *maps, uint32_t map_count, const rsm_gather_desc *desc);
/* Bounced light of all maps at every pixel, from the samples that rsm_gather takes for the same desc.
   seen     NULL = no pixels: only the list of lights by flux is made, for shaders of your own (glbk_rsm_bind)
   desc     NULL = all defaults: every texel. noise, materials and a pattern about the receiver need the tables of this
            desc. A program of your own that is to have near_field, too, needs RSM_SURFACES=1 among its defines
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_DESC, GLBK_ERR_MISMATCH (glbk_rsm_tables_upload was not given this desc last;
            a G-buffer of another size) */

GLBK_DEF glbk_result glbk_rsm_interpolate(glbk_context *ctx, glbk_rsm_renderer *renderer, const glbk_gbuffer *seen,
                                          glbk_rsm_map *const *maps, uint32_t map_count,
                                          const rsm_gather_desc *desc,
                                          const rsm_interpolation *interpolation);
/* The same as rsm_interpolate does it: first a low-resolution picture, then the pixels between where 3 of 4 samples
   suit, then finer grids, at last single pixels, each only where a mask in alpha, or by compute a list, says that
   something is left: nothing is asked back from the GPU.
   desc     NULL = all defaults; noise and interleave must be off
   interpolation   NULL = all defaults
   Errors   as glbk_rsm_gather; GLBK_ERR_ORDER (a renderer without memory for it) */

GLBK_DEF glbk_result glbk_rsm_denoise(glbk_context *ctx, glbk_rsm_renderer *renderer, const glbk_gbuffer *seen,
                                      const gifilt_frame *frame, const glbk_texture *motion);
/* What gifilt_apply does to the bounced light. Once a frame, after it was gathered. Keeps places and normals of the
   G-buffer for the next frame by itself.
   frame    NULL = all defaults
   motion   NULL, or where each pixel's surface was: pixels of the last frame in r and g
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_DESC, GLBK_ERR_MISMATCH (a G-buffer of another size), GLBK_ERR_ORDER (nothing is
            gathered, or it was filtered already; a renderer without memory for it) */
GLBK_DEF void glbk_rsm_forget(glbk_rsm_renderer *renderer);
/* The next frame starts anew. */

GLBK_DEF glbk_result glbk_rsm_resolve(glbk_context *ctx, glbk_rsm_renderer *renderer, const glbk_gbuffer *seen,
                                      const glbk_pass *pass, const glbk_picture *picture, int direct, int bounced);
/* Draws albedo (the diffuse colour; metal-rough: times 1 - metallic) / pi times the light that is wanted, linear
   radiance, to the pass's target; viewports: see glbk_pass.
   picture   or NULL, see glbk_picture */

GLBK_DEF glbk_result glbk_rsm_read(glbk_context *ctx, glbk_rsm_renderer *renderer, int bounced, float *rgba);
/* Irradiance, direct or bounced: 4 floats a pixel. Waits for the GPU. a of bounced light, before glbk_rsm_denoise: 2
   interpolated, above evaluated, 0 nothing seen. Errors: GLBK_ERR_ORDER (there is no such light yet) */

GLBK_DEF void glbk_rsm_bind(glbk_context *ctx, const glbk_rsm_renderer *renderer, const glbk_rsm_map *map,
                            const glbk_offset *offset);
/* For a program of yours with rsm_direct, rsm_gather or rsm_bounce among its library files, which is bound: the map's
   textures and light; with a renderer its list of lights as the last glbk_rsm_gather left it and tables.
   Either may be NULL. rsm_screen reads the G-buffer: glbk_gbuffer_bind, and glbk_gbuffer_part() among the parts.
   offset   that rsm has in the program; NULL = none
   By flux, without interleave, the list holds the samples of one map after the other, of all if they are
   lights_per_pass or fewer, else their last ones. Where nothing but the list is wanted, a renderer of 1 x 1 pixels
   and no G-buffer do. */
