/* ---- ism: imperfect shadow maps, after ism.h ----

   ism.h chooses VPLs (ism_choose) and scatters surfels over the mesh (ism_scatter); from these lists the maps
   are drawn and the pixels of a G-buffer lit here: surfels as discs by the depth test, pull and push, light
   of all VPLs with visibility, interleaved sampling and its blur. Where ctx->compute, each of these is one
   dispatch that works in shared memory, to the same numbers. Descs, settings and lists are ism.h's, with the
   same defaults, and the numbers are those of ism.h to float rounding. A surfel is a triangle and its
   barycentric coordinates there, so moving geometry is new positions alone. A frame, after ism_choose and
   ism_scatter:

       glbk_ism_surfels_upload(gl, &maps, phase, surfels);          // of ism_phase_surfels; first all phases
       glbk_ism_vpls_upload(gl, &maps, vpls, n, center, radius);    // of ism_vpls and ism_get_info
       glbk_ism_near_points_upload(gl, &maps, points, count);       // of ism_near_points
       glbk_ism_mesh_move(gl, &maps, positions, 0);                 // where something moved
       glbk_ism_draw(gl, &maps, 0);
       glbk_gbuffer_begin(gl, &seen, world_to_clip, eye); ...       // what the camera sees: gl_gbuffer.h
       glbk_ism_shade(gl, &renderer, &seen, &maps, NULL, 0);
       glbk_ism_resolve(gl, &renderer, &seen, &pass, NULL);

   For shaders of your own, lib/ism_light.glsl with glbk_ism_bind:

       vec4 ism_light(vec3 p, vec3 n, vec3 ng, uint first, uint pattern);
       float ism_visible(uint v, ism_vpl l, vec3 p, vec3 ng, float bias);     // 1 lit, 0 not

   World space; n, ng: unit, for shading and the surface's own; l: ism_read_vpl(v). ism_light takes the VPLs
   first, first + pattern, ... (0u, 1u: all), times pattern. Result: rgb irradiance, W/m^2; a: what the rule
   near by took off, mean of the channels. */

#define GLBK_ISM_TEXTURES(X)                                                                        \
    X(sampler2DArray, glbk_ism_vpls, 0)         /* 4 texels each; then near points: docs/gpu-layouts.md */  \
    X(usampler2DArray, glbk_ism_surfels, 1)                                                          \
    X(usampler2DArray, glbk_ism_triangles, 2)   /* three indices, opacity */                        \
    X(sampler2DArray, glbk_ism_positions, 3)                                                        \
    X(usampler2D, glbk_ism_atlas, 4)            /* depths, floats as bits */                        \
    X(glbk_color_sampler, glbk_ism_planes, 5)   /* plane and depth of a texel's nearest surfel */   \
    X(usampler2D, glbk_ism_below, 6)            /* texels that are kept, or the level below */      \
    X(glbk_color_sampler, glbk_ism_light, 7)    /* before the blur, or after it; 8 to 11: the G-buffer */ \
    X(usampler2D, glbk_ism_pull1, 12)           /* these three follow each other */                 \
    X(usampler2D, glbk_ism_pull2, 13)                                                               \
    X(usampler2D, glbk_ism_pull3, 14)

#define GLBK_ISM_FRAME_MEMBERS(X)                                                                   \
    X(uvec4, maps, 1)       /* VPLs in use, texels a tile's side, tiles a side, surfels of a VPL */ \
    X(uvec4, surfels, 1)    /* VPLs at most, surfels of one in a phase, levels of the fill, triangles */ \
    X(vec4, sphere, 1)      /* about the mesh: centre, radius */                                    \
    X(vec4, values, 1)      /* area of a disc over its surfel's; texels a tile's side outside of windows */ \
    X(uvec4, near_points, 1) /* how many; where in glbk_ism_vpls their spheres begin, and they themselves;
                                first surfel of a draw of rectangles */
#define GLBK_ISM_VIEW_MEMBERS(X)                                                                    \
    X(uvec4, size, 1)       /* width, height, pattern, not 0: no maps */                            \
    X(vec4, values, 1)      /* bias, clamp, first row of a dispatch */
#define GLBK_ISM_BLOCKS(X)                          \
    X(glbk_ism_frame, 0, GLBK_ISM_FRAME_MEMBERS)    \
    X(glbk_ism_view, 1, GLBK_ISM_VIEW_MEMBERS)
#define GLBK_ISM_STORAGE(X)
#define GLBK_ISM_IMAGES(X)                                              \
    X(writeonly, rgba32f, image2D, glbk_ism_planes_out, 0)             \
    X(writeonly, r32ui, uimage2D, glbk_ism_atlas_out, 1)                \
    X(writeonly, rgba32f, image2D, glbk_ism_light_out, 2)       /* before the blur, or after it */

GLBK__PART(ISM)

GLBK_DEF const glbk_part *glbk_ism_part(void);
/* The GLSL of this header, for programs of your own that use its library files: glbk_source.parts. */

#define GLBK_ISM_LEVELS 3u

typedef struct glbk_ism_maps {          /* read only; zeroed = none */
    ism_desc     desc;                  /* defaults resolved; 0 near points, 0 window_rim: none; no system */
    uint32_t     side, tiles_across;    /* of the atlas, in texels and tiles: as ism_atlas has them */
    uint32_t     phase_surfel_count;    /* of a VPL in a phase: surfel_count / lazy_frames, rounded up */
    uint32_t     vpl_count, near_point_count;       /* in use */
    uint32_t     vertex_count, triangle_count;
    uint64_t     phases;                /* bits: those that were given */
    int          drawn;                 /* by glbk_ism_draw */
    float        sphere[4];             /* about the mesh: centre, radius */
    glbk_texture vpls, surfels, triangle_table, positions;
    glbk_texture planes, depth, kept, pull[GLBK_ISM_LEVELS], atlas;
    glbk_target  plane_target, kept_target, pull_target[GLBK_ISM_LEVELS], atlas_target;
    glbk_buffer  frame, view;           /* view: of glbk_ism_bind */
    int          quads;                 /* rectangles are drawn in place of points */
    glbk_program splat, holes, pull_program[GLBK_ISM_LEVELS], push;
    int          compute;               /* the compute path: no depth, kept and pull */
    glbk_program fill;
    glbk_texture phase_surfels[64];     /* the core path's surfels: those drawn with are left alone */
} glbk_ism_maps;

GLBK_DEF glbk_result glbk_ism_maps_create(glbk_context *ctx, const ism_desc *desc, glbk_ism_maps *out);
/* desc     that of the ism_create whose lists are drawn; NULL = all defaults. vpl_count, surfel_count,
            tile_side, projection, lazy_frames, splat_scale, near_point_count, window_rim and no_fill are
            looked at. What else it says, its system too, is about the choice of these lists by ism.h
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, a field out of range; GLBK_ERR_LIMIT where the atlas is wider
            than ctx->max_side; those of programs, textures and targets
   Where ctx->compute, out->compute: the compute path, unless surfels rounded up to lazy_frames phases are
   more than 65,536 a VPL. Memory on the GPU: 26 bytes a texel of the atlas, by compute 20, and 16 a surfel:
   of 1024 VPLs with 64 x 64 texels and 8192 surfels 109 (84) + 134 MB */
GLBK_DEF void glbk_ism_maps_free(glbk_context *ctx, glbk_ism_maps *maps);

GLBK_DEF glbk_result glbk_ism_mesh_upload(glbk_context *ctx, glbk_ism_maps *maps, const ism_mesh *mesh);
/* What throws shadows. Where the number of triangles changes, the surfels of all phases must be given anew.
   mesh     NULL = nothing; its albedos are not looked at
   Errors   GLBK_ERR_ARGUMENT, arrays, counts or strides; GLBK_ERR_INPUT, an index beyond vertex_count;
            GLBK_ERR_LIMIT, GLBK_ERR_ALLOC */
GLBK_DEF glbk_result glbk_ism_mesh_move(glbk_context *ctx, glbk_ism_maps *maps, const float *positions,
                                        size_t stride);
/* New places of the same vertices. Or render them into layers of maps->positions, an RGBA32F table, yourself;
   surfels are then scattered by ism.h over the places that you give it.
   stride   bytes, a multiple of 4, >= 12; 0 = 12
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_ORDER (there is no mesh), GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_ism_surfels_upload(glbk_context *ctx, glbk_ism_maps *maps, uint32_t phase,
                                             const ism_surfel *surfels);
/* The surfels of one phase, of all VPLs, as ism_phase_surfels writes them.
   phase    below lazy_frames; a frame changes phase index % lazy_frames alone, the first frame needs all
   surfels  vpl_count * maps->phase_surfel_count
   Errors   GLBK_ERR_ARGUMENT */

GLBK_DEF glbk_result glbk_ism_vpls_upload(glbk_context *ctx, glbk_ism_maps *maps, const ism_vpl *vpls,
                                          uint32_t count, const float center[3], float radius);
/* vpls     as ism_vpls has them; area, source, texel and jumped are not looked at
   count    0 is no light
   center   and radius: of ism_get_info, for directional VPLs; NULL without
   There are no near points afterwards, until glbk_ism_near_points_upload.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_INPUT, what ism_set_vpls refuses, a negative side or reach, a window
            that leaves nothing; GLBK_ERR_LIMIT, more than desc.vpl_count; GLBK_ERR_ALLOC */
GLBK_DEF glbk_result glbk_ism_near_points_upload(glbk_context *ctx, glbk_ism_maps *maps,
                                                 const ism_near_point *points, uint32_t count);
/* After glbk_ism_vpls_upload, for ISM_NEAR_GATHER, the default.
   points   as ism_near_points has them
   count    0 is none: ISM_NEAR_GATHER then is ISM_NEAR_PATCH
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_INPUT, what is not finite or negative, or the number of no VPL;
            GLBK_ERR_LIMIT, more than desc.vpl_count * desc.near_point_count; GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_ism_draw(glbk_context *ctx, glbk_ism_maps *maps, uint32_t surfels_per_pass);
/* Draws all maps: a draw for each phase or surfels_per_pass of it, then 1 + 3 + 1 passes; or by compute two
   dispatches. Where ctx->max_point_side is below tile_side, the core path has rectangles instead of points.
   surfels_per_pass   of the core path; 0 = 2^20: a draw must not outlast the driver's patience
   Errors             GLBK_ERR_ARGUMENT; GLBK_ERR_ORDER: a phase was not given yet; GLBK_ERR_LOST */
GLBK_DEF glbk_result glbk_ism_maps_read(glbk_context *ctx, const glbk_ism_maps *maps, float *atlas);
/* side * side depths as ism_atlas has them. Waits for the GPU. Errors: GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC. */

GLBK_DEF glbk_result glbk_ism_bind(glbk_context *ctx, const glbk_ism_maps *maps, const ism_shading *shading,
                                   const glbk_offset *offset);
/* For ism_light() and ism_visible() of lib/ism_light.glsl in a program of your own, which is bound
   (glbk_begin) and has ISM_NEAR, the number of a near_mode (0 and 6 are ISM_NEAR_GATHER), and ISM_PROJECTION,
   that of maps->desc.projection, among its defines.
   shading  bias, clamp and no_maps count; NULL = all defaults
   offset   that ism has in the program; NULL = none
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, a field out of range */

/* ---- ism: complete passes ---- */

typedef struct glbk_ism_renderer {      /* read only; zeroed = none */
    uint32_t     width, height;
    glbk_texture light, result;         /* irradiance before the blur and after it: GLBK_FORMAT_COLOR */
    glbk_target  light_target, result_target;
    glbk_buffer  view;
    glbk_program shade[ISM_PROJECTION_COUNT][ISM_NEAR_COUNT], blur, resolve;
    int          compute;
} glbk_ism_renderer;

GLBK_DEF glbk_result glbk_ism_renderer_create(glbk_context *ctx, uint32_t width, uint32_t height,
                                              glbk_ism_renderer *out);
/* Memory on the GPU: 32 bytes a pixel. Errors: GLBK_ERR_ARGUMENT, GLBK_ERR_DESC (a size of 0, or more than
   ctx->max_side), those of programs, textures and targets */
GLBK_DEF void glbk_ism_renderer_free(glbk_context *ctx, glbk_ism_renderer *renderer);

GLBK_DEF glbk_result glbk_ism_shade(glbk_context *ctx, glbk_ism_renderer *renderer,
                                    const glbk_gbuffer *gbuffer, const glbk_ism_maps *maps,
                                    const ism_shading *shading, uint32_t pairs_per_pass);
/* Lights every pixel by all VPLs, as ism_shade does without albedos. The first use of a near_mode compiles a
   program.
   gbuffer          of the renderer's size
   shading          NULL = all defaults. visible_fn and near_visible_fn must be NULL; cull makes no difference
   pairs_per_pass   of a pixel and a VPL; 0 = 2^28: a pass must not outlast the driver's patience
   Errors           GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, a field of the shading; GLBK_ERR_MISMATCH, another size;
                    GLBK_ERR_ORDER, maps that were never drawn, without no_maps; those of
                    glbk_program_create */
GLBK_DEF glbk_result glbk_ism_resolve(glbk_context *ctx, glbk_ism_renderer *renderer,
                                      const glbk_gbuffer *gbuffer, const glbk_pass *pass,
                                      const glbk_picture *picture);
/* Draws irradiance x albedo / pi, linear radiance, to the pass's target; viewports: see glbk_pass. Of
   metal-rough surfaces the albedo is that of what is no metal.
   picture  or NULL, see glbk_picture
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_MISMATCH; those of glbk_begin */
GLBK_DEF glbk_result glbk_ism_read(glbk_context *ctx, const glbk_ism_renderer *renderer, float *rgba);
/* The irradiance: 4 floats a pixel. a: the irradiance, mean of the three channels, that clamping or spheres
   took off. Waits for the GPU. Errors: GLBK_ERR_ARGUMENT. */
