/* ---- ism: imperfect shadow maps, after ism.h ----

   ism.h chooses VPLs (ism_choose) and scatters points over the mesh (ism_scatter); from plain arrays of both the maps
   are drawn and pixels shaded here: points as discs by the depth test, pull and push, light of all VPLs with
   visibility, interleaved sampling and its blur. Where ctx->compute, each of these is one dispatch that works in shared
   memory, to the same numbers. Points are triangles and barycentric coordinates, the mesh two tables of indices
   and positions: moving geometry is new positions alone. The numbers are those of ism.h to float rounding.
   In every frame: glbk_ism_phase, glbk_ism_vpls_upload, glbk_ism_draw, glbk_ism_shade. For shaders of your own,
   lib/ism_light.glsl with glbk_ism_bind:

       vec4 ism_light(vec3 p, vec3 n, vec3 ng, uint first, uint pattern);
       float ism_visible(uint v, ism_vpl l, vec3 p, vec3 ng, float bias);     // 1 lit, 0 not; l: ism_read_vpl(v)

   World space; n, ng: unit, for shading and the surface's own. VPLs first, first + pattern, ... (0u, 1u: all), times
   pattern. Result: rgb irradiance, W/m^2; a: what the rule near by took off, mean of the channels. */

#define GLBK_ISM_TEXTURES(X)                                                                        \
    X(sampler2DArray, glbk_ism_vpls, 0)         /* 4 texels each; spheres of near points; these, 3 each */  \
    X(usampler2DArray, glbk_ism_points, 1)                                                          \
    X(usampler2DArray, glbk_ism_triangles, 2)   /* three indices, opacity */                        \
    X(sampler2DArray, glbk_ism_positions, 3)                                                        \
    X(glbk_color_sampler, glbk_ism_surfels, 5)  /* plane and depth */                               \
    X(usampler2D, glbk_ism_below, 6)            /* texels that are kept, or the level below */      \
    X(usampler2D, glbk_ism_pull1, 7)                                                                \
    X(usampler2D, glbk_ism_pull2, 8)                                                                \
    X(usampler2D, glbk_ism_pull3, 9)                                                                \
    X(usampler2D, glbk_ism_atlas, 10)           /* depths, floats as bits */                        \
    X(glbk_color_sampler, glbk_ism_place, 11)   /* G-buffer */                                      \
    X(glbk_color_sampler, glbk_ism_normal, 12)                                                      \
    X(glbk_color_sampler, glbk_ism_geometric, 13)                                                   \
    X(glbk_color_sampler, glbk_ism_albedo, 14)                                                      \
    X(glbk_color_sampler, glbk_ism_light, 15)   /* before the blur */

#define GLBK_ISM_FRAME_MEMBERS(X)                                                                   \
    X(uvec4, maps, 1)       /* VPLs in use, texels a tile's side, tiles a side, points of a VPL in all phases */     \
    X(uvec4, points, 1)     /* VPLs at most, points of one in a phase, levels of the fill, triangles */  \
    X(vec4, sphere, 1)      /* about the mesh: centre, radius */                                    \
    X(vec4, values, 1)      /* area of a disc over its point's; texels a tile's side outside of windows */  \
    X(uvec4, near_points, 1) /* how many; where their spheres and they themselves begin in glbk_ism_vpls; first point
                               of a draw of rectangles */
#define GLBK_ISM_VIEW_MEMBERS(X)                                                                    \
    X(uvec4, size, 1)       /* width, height (resolving: corner), pattern; 1: no maps, 2: times albedo */ \
    X(vec4, values, 1)      /* bias, clamp, first row of a dispatch */
#define GLBK_ISM_BLOCKS(X)                          \
    X(glbk_ism_frame, 0, GLBK_ISM_FRAME_MEMBERS)    \
    X(glbk_ism_view, 1, GLBK_ISM_VIEW_MEMBERS)
#define GLBK_ISM_STORAGE(X)
#define GLBK_ISM_IMAGES(X)                                              \
    X(writeonly, rgba32f, image2D, glbk_ism_surfels_out, 0)             \
    X(writeonly, r32ui, uimage2D, glbk_ism_atlas_out, 1)                \
    X(writeonly, rgba32f, image2D, glbk_ism_light_out, 2)       /* before the blur, or after it */

GLBK__PART(ISM)

GLBK_DEF const glbk_part *glbk_ism_part(void);
/* The GLSL of this header, for programs of your own that use its library files: glbk_source.parts. */

typedef struct glbk_ism_desc {      /* the sizes of ism_desc: points is surfel_count there, tile_size tile_side, lazy
                                       lazy_frames, near_points near_point_count */
    uint32_t vpl_count;             /* at most, 1..16384; 0 = 1024 */
    uint32_t points;                /* of each VPL, 8..65536; 0 = 8192 */
    uint32_t tile_size;             /* texels a side, power of two, 8..256; 0 = 64 */
    uint32_t projection;            /* ism_projection; 0 = cosine */
    uint32_t lazy;                  /* frames until all points are renewed, 1..64; 0 = 8 */
    float    splat_scale;           /* above 0, <= 16; 0 = 1 */
    int      no_fill;               /* not 0: no pull and push */
    uint32_t near_points;           /* of each VPL, at most 64; 0 = 16 */
    uint32_t window_rim;            /* 2..tile_size / 2; 0 = tile_size / 8, at least 2 */
    uint32_t points_per_pass;       /* of the core path; 0 = 2^20: a draw must not outlast the driver's patience */
} glbk_ism_desc;

#define GLBK_ISM_LEVELS 3u

typedef struct glbk_ism_maps {      /* read only; zeroed = none */
    glbk_ism_desc desc;             /* defaults resolved */
    uint32_t      side, tiles;      /* of the atlas, in texels and tiles */
    uint32_t      each;             /* points of a VPL in a phase */
    uint32_t      count;            /* VPLs in use */
    uint32_t      vertices, triangles;
    uint64_t      phases;           /* bits: those that were given */
    float         sphere[4];
    glbk_texture  vpls, points, triangle_table, positions, surfels, depth, kept, pull[GLBK_ISM_LEVELS], atlas;
    glbk_target   surfel_target, kept_target, pull_target[GLBK_ISM_LEVELS], atlas_target;
    glbk_buffer   frame, view;      /* view: of glbk_ism_bind */
    int           quads;            /* rectangles in place of points */
    glbk_program  splat, holes, pull_program[GLBK_ISM_LEVELS], push;
    int           compute;          /* the compute path: no depth, kept and pull */
    glbk_program  fill;
    uint32_t      near_count;       /* near points in use */
    glbk_texture  phase_points[64]; /* the core path's in place of points, so that those drawn with are left alone */
} glbk_ism_maps;

GLBK_DEF glbk_result glbk_ism_maps_create(glbk_context *ctx, const glbk_ism_desc *desc, glbk_ism_maps *out);
/* desc     NULL = all defaults
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_LIMIT where the atlas is wider than ctx->max_side; GLBK_ERR_COMPILE and so on
   Where ctx->compute, out->compute: the compute path, unless points rounded up to lazy phases are more than 65,536 a
   VPL. Memory on the GPU: 26 bytes a texel of the atlas, by compute 20, and 16 a point: 1024 VPLs of 64 x 64 texels and
   8192 points 109 (84) + 134 MB */
GLBK_DEF void glbk_ism_maps_free(glbk_context *ctx, glbk_ism_maps *maps);

GLBK_DEF glbk_result glbk_ism_mesh_upload(glbk_context *ctx, glbk_ism_maps *maps, const ism_mesh *mesh);
/* What throws shadows. Where the number of triangles changes all points must be given anew.
   mesh     NULL = nothing; its albedos are not looked at
   Errors   GLBK_ERR_ARGUMENT: sizes, or an index beyond vertex_count; GLBK_ERR_LIMIT, GLBK_ERR_ALLOC */
GLBK_DEF glbk_result glbk_ism_mesh_move(glbk_context *ctx, glbk_ism_maps *maps, const float *positions, size_t stride);
/* New places of the same vertices. Or render them into layers of maps->positions, an RGBA32F table, yourself; points
   are then scattered by ism.h over the places that you give it. Errors: GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC. */

GLBK_DEF glbk_result glbk_ism_phase(glbk_context *ctx, glbk_ism_maps *maps, uint32_t phase, const void *points);
/* The points of one phase, 16 bytes each, of all VPLs, as ism_phase_surfels writes them: vpl_count
   * maps->each.
   phase    below lazy; a frame changes phase index % lazy alone, the first frame needs all
   Errors   GLBK_ERR_ARGUMENT */

GLBK_DEF glbk_result glbk_ism_vpls_upload(glbk_context *ctx, glbk_ism_maps *maps, const ism_vpl *vpls,
                                          uint32_t count, const float center[3], float radius);
/* vpls     as ism_vpls has them: position, normal, flux, axis, exponent, side, directional, reach and window count
   count    <= vpl_count; 0 is no light
   center   and radius: of ism_get_info, for directional VPLs; NULL without
   There are no near points afterwards, until glbk_ism_near_upload.
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC */
GLBK_DEF glbk_result glbk_ism_near_upload(glbk_context *ctx, glbk_ism_maps *maps, const void *points, uint32_t count);
/* After glbk_ism_vpls_upload, for near_mode 6.
   points   count times 48 bytes, as ism_near_points has them
   count    <= vpl_count * near_points; 0 is none: near_mode 6 then is 1
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_ism_draw(glbk_context *ctx, glbk_ism_maps *maps);
/* Draws all maps: a draw for each phase or points_per_pass of it, then 1 + 3 + 1 passes, or by compute two dispatches.
   Where ctx->max_point_side is below tile_size, the core path has rectangles instead of points.
   Errors   GLBK_ERR_ARGUMENT: a phase was not given yet; GLBK_ERR_LOST */
GLBK_DEF glbk_result glbk_ism_read(glbk_context *ctx, const glbk_ism_maps *maps, float *atlas);
/* side * side depths as ism_atlas has them. Waits for the GPU. Errors: GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC. */

typedef struct glbk_ism_renderer {  /* read only; zeroed = none */
    uint32_t     width, height;
    glbk_texture gbuffer[4], depth; /* places, normals, face normals, albedos: GLBK_FORMAT_COLOR */
    glbk_target  gbuffer_target;    /* to draw them yourself: four outputs of type glbk_color, a cleared normal is
                                       background */
    glbk_texture light, result;     /* result is what was asked for: GLBK_FORMAT_COLOR, for your own passes */
    glbk_target  light_target, result_target;
    glbk_buffer  view;
    glbk_program shade[4][6], blur, resolve;        /* shade: by projection and near_mode */
    int          compute;
} glbk_ism_renderer;

GLBK_DEF glbk_result glbk_ism_renderer_create(glbk_context *ctx, uint32_t width, uint32_t height,
                                              glbk_ism_renderer *out);
GLBK_DEF void glbk_ism_renderer_free(glbk_context *ctx, glbk_ism_renderer *renderer);

typedef struct glbk_ism_receivers { /* as ism_points has them: width * height of each, row 0, the lowest, first */
    const float *positions, *normals;
    const float *geometric;         /* NULL = normals */
    const float *albedos;           /* NULL = 1 */
    size_t       stride;            /* bytes, of all four; 0 = 12 */
} glbk_ism_receivers;

GLBK_DEF glbk_result glbk_ism_gbuffer_upload(glbk_context *ctx, glbk_ism_renderer *renderer,
                                             const glbk_ism_receivers *receivers);
/* Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC */

typedef struct glbk_ism_shading {   /* fields as in ism_shading. NULL for one: all 0 but bias 0.02 and clamp 1; in one a
                                       bias of 0 is 0 */
    uint32_t pattern;               /* 1, 2, 4, 8; 0 = 1 */
    uint32_t near_mode;             /* ism_near; 0 = 6, gather */
    float    clamp, bias;
    int      no_maps;
    int      irradiance;            /* not 0: not times albedo / pi */
    uint32_t pairs_per_pass;        /* of a pixel and a VPL; 0 = 2^28: likewise */
} glbk_ism_shading;

GLBK_DEF glbk_result glbk_ism_bind(glbk_context *ctx, const glbk_ism_maps *maps, const glbk_ism_shading *shading,
                                   const glbk_offset *offset);
/* For ism_light() and ism_visible() of lib/ism_light.glsl in a program of your own, which is bound (glbk_begin) and
   compiled with ISM_NEAR=near_mode and ISM_PROJECTION=maps->desc.projection among its defines.
   shading  bias, clamp and no_maps count; may be NULL, see glbk_ism_shading
   offset   that ism has in the program; NULL = none
   Errors   GLBK_ERR_ARGUMENT */

GLBK_DEF glbk_result glbk_ism_shade(glbk_context *ctx, glbk_ism_renderer *renderer, const glbk_ism_maps *maps,
                                    const glbk_ism_shading *shading);
/* shading  may be NULL, see glbk_ism_shading
   Errors   GLBK_ERR_ARGUMENT; those of glbk_program_create at a near_mode's first use */
GLBK_DEF glbk_result glbk_ism_resolve(glbk_context *ctx, glbk_ism_renderer *renderer, const glbk_pass *pass,
                                      const glbk_picture *picture);
/* Draws the result, linear, to the pass's target; its blending adds it to what is there. Viewports: see glbk_pass.
   picture   or NULL, see glbk_picture
   Errors GLBK_ERR_ARGUMENT; those of glbk_buffer_update */
GLBK_DEF glbk_result glbk_ism_read_light(glbk_context *ctx, const glbk_ism_renderer *renderer, float *rgb);
/* width * height * 3 floats, row 0, the lowest, first. Waits for the GPU. result's fourth channel is the irradiance,
   mean of the three channels, that clamping or spheres took off. Errors: GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC. */
