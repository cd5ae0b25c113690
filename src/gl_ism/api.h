/* ---- ism: imperfect shadow maps, after ism.h ----

   ism.h chooses the VPLs (ism_choose) and scatters surfels over the mesh (ism_scatter). From these lists the
   maps are drawn here and the pixels of a G-buffer are lit: surfels are drawn as discs with the depth test,
   pull and push fill the holes between them, and each pixel sums the light of its VPLs with visibility,
   interleaved with its neighbours and blurred afterwards. If ctx->compute is set, each of these steps is one
   dispatch in shared memory. Descs, settings and lists are the structs of ism.h with the same defaults, and
   results are those of ism.h up to the rounding of floats. A surfel is a triangle and barycentric coordinates
   in it, so geometry that moves needs nothing but new positions. A frame, after ism_choose and ism_scatter:

       glbk_ism_surfels_upload(gl, &maps, phase, surfels, m);       // of ism_phase_surfels; at first all
       glbk_ism_vpls_upload(gl, &maps, vpls, n, &info);             // of ism_vpls and ism_get_info
       glbk_ism_near_points_upload(gl, &maps, points, count);       // of ism_near_points
       glbk_ism_mesh_move(gl, &maps, positions, 0);                 // if something moved
       glbk_ism_draw(gl, &maps, 0);
       glbk_gbuffer_begin(gl, &seen, world_to_clip, eye); ...       // what the camera sees: gl_gbuffer.h
       glbk_ism_shade(gl, &renderer, &seen, &maps, NULL, 0);
       glbk_ism_resolve(gl, &renderer, &seen, &pass, NULL);

   Shaders of your own call these functions of lib/ism_light.glsl, after glbk_ism_bind:

       vec4 ism_light(vec3 p, vec3 n, vec3 ng, uint first, uint pattern);
       float ism_visible(uint v, ism_vpl l, vec3 p, vec3 ng, float bias);   // 1 lit, 0 not
       ism_vpl ism_read_vpl(uint v);                                        // l of ism_visible

   ism_light returns in rgb the irradiance of a point by VPLs first, first + pattern, ..., times pattern, in
   W/m^2 (0u and 1u: all VPLs), and in a the irradiance, mean of the channels, that the rule near by took off.
   p is in world space; n and ng are unit, n for shading and ng the surface's own. */

#define GLBK_ISM_TABLES(X)                                                                              \
    X(sampler2DArray, glbk_ism_vpls, 0)         /* VPLs and near points: docs/gpu-layouts.md */         \
    X(usampler2DArray, glbk_ism_surfels, 1)                                                             \
    X(usampler2DArray, glbk_ism_triangles, 2)   /* three indices and opacity */                         \
    X(sampler2DArray, glbk_ism_positions, 3)

#define GLBK_ISM_PICTURES(X)                                                                            \
    X(usampler2D, glbk_ism_atlas, 4)            /* depths, floats as bits */                            \
    X(glbk_color_sampler, glbk_ism_planes, 5)   /* plane and depth of a texel's nearest surfel */       \
    X(usampler2D, glbk_ism_below, 6)            /* texels that are kept, or the level below */          \
    X(glbk_color_sampler, glbk_ism_light, 7)    /* irradiance; 8 to 11 are the G-buffer's */            \
    X(usampler2D, glbk_ism_pull1, 12)           /* levels of pull: these three are neighbours */        \
    X(usampler2D, glbk_ism_pull2, 13)                                                                   \
    X(usampler2D, glbk_ism_pull3, 14)

#define GLBK_ISM_TEXTURES(X) GLBK_ISM_TABLES(X) GLBK_ISM_PICTURES(X)

#define GLBK_ISM_COUNT_MEMBERS(X)                                                                       \
    X(uint, vpl_count, 1)           /* VPLs in use */                                                   \
    X(uint, tile_side, 1)           /* texels a side of a VPL's tile */                                 \
    X(uint, tiles_across, 1)        /* tiles a side of the atlas */                                     \
    X(uint, surfel_count, 1)        /* surfels of a VPL, in all phases */                               \
    X(uint, vpl_capacity, 1)        /* VPLs that there is room for */                                   \
    X(uint, phase_surfel_count, 1)  /* surfels of a VPL in one phase */                                 \
    X(uint, fill_levels, 1)         /* levels of pull and push; 0 = holes stay */                       \
    X(uint, triangle_count, 1)

#define GLBK_ISM_MESH_MEMBERS(X)                                                                        \
    X(vec4, sphere, 1)              /* about the mesh: centre, radius */                                \
    X(float, splat_scale, 1)        /* area of a disc over that of its surfel */                        \
    X(uint, window_rim, 1)          /* texels a side of a tile outside of its window */                 \
    X(uint, near_point_count, 1)    /* near points in use */                                            \
    X(uint, first_sphere, 1)        /* where in glbk_ism_vpls their spheres begin, */                   \
    X(uint, first_near_point, 1)    /* and where they themselves */                                     \
    X(uint, first_surfel, 1)        /* of a draw of rectangles: the surfel of instance 0 */             \
    X(uint, unused0, 1)                                                                                 \
    X(uint, unused1, 1)

#define GLBK_ISM_FRAME_MEMBERS(X) GLBK_ISM_COUNT_MEMBERS(X) GLBK_ISM_MESH_MEMBERS(X)

#define GLBK_ISM_VIEW_MEMBERS(X)                                                                        \
    X(uint, width, 1)               /* of the picture, in pixels */                                     \
    X(uint, height, 1)                                                                                  \
    X(uint, pattern, 1)             /* pixels a side that share the VPLs */                             \
    X(uint, no_maps, 1)             /* not 0: all VPLs are visible */                                   \
    X(float, bias, 1)               /* these two as in ism_shading, with its defaults */                \
    X(float, clamp_at, 1)                                                                               \
    X(uint, first_row, 1)           /* of a dispatch */                                                 \
    X(uint, unused0, 1)

#define GLBK_ISM_BLOCKS(X)                                                                              \
    X(glbk_ism_frame, 0, GLBK_ISM_FRAME_MEMBERS)                                                        \
    X(glbk_ism_view, 1, GLBK_ISM_VIEW_MEMBERS)

#define GLBK_ISM_STORAGE(X)
#define GLBK_ISM_IMAGES(X)                                                                              \
    X(writeonly, rgba32f, image2D, glbk_ism_planes_out, 0)                                              \
    X(writeonly, r32ui, uimage2D, glbk_ism_atlas_out, 1)                                                \
    X(writeonly, rgba32f, image2D, glbk_ism_light_out, 2)       /* before the blur, or after it */

GLBK__PART(ISM)

GLBK_DEF const glbk_part *glbk_ism_part(void);
/* Returns the GLSL of this header, for programs of your own that use its library files: see
   glbk_source.parts. */

#define GLBK_ISM_LEVELS 3u              /* the most levels of pull and push */

typedef struct glbk_ism_maps {          /* the maps of all VPLs; read only; zeroed = none */
    ism_desc     desc;                  /* with its defaults, 0 for none, and without its system */
    uint32_t     side;                  /* texels a side of the atlas, */
    uint32_t     tiles_across;          /* and tiles a side, both as ism_atlas has them */
    uint32_t     phase_surfel_count;    /* of a VPL in a phase: surfel_count / lazy_frames, rounded up */
    uint32_t     vpl_count;             /* in use */
    uint32_t     near_point_count;      /* in use */
    uint32_t     vertex_count;
    uint32_t     triangle_count;
    uint64_t     phases;                /* a bit for each phase whose surfels were given */
    int          drawn;                 /* not 0: glbk_ism_draw has succeeded once */
    float        sphere[4];             /* about the mesh: centre, radius */
    glbk_texture vpls;                  /* tables: VPLs and near points, */
    glbk_texture surfels;               /* surfels of all phases (compute path), */
    glbk_texture triangle_table;        /* triangles, */
    glbk_texture positions;             /* vertices */
    glbk_texture planes;                /* pictures of the atlas's size: the nearest surfels, */
    glbk_texture depth;                 /* the depth buffer they are drawn with, */
    glbk_texture kept;                  /* which texels keep their surfels, */
    glbk_texture pull[GLBK_ISM_LEVELS]; /* the levels of pull, each of half the size of the one before, */
    glbk_texture atlas;                 /* the depths of all maps */
    glbk_target  plane_target;
    glbk_target  kept_target;
    glbk_target  pull_target[GLBK_ISM_LEVELS];
    glbk_target  atlas_target;
    glbk_buffer  frame;                 /* uniform blocks: of the maps, */
    glbk_buffer  view;                  /* of glbk_ism_bind */
    glbk_program splat;                 /* draws surfels */
    glbk_program holes;                 /* finds holes */
    glbk_program pull_program[GLBK_ISM_LEVELS];
    glbk_program push;                  /* fills holes */
    glbk_program fill;                  /* does all three by compute */
    int          quads;                 /* not 0: surfels are drawn as rectangles, not as points */
    int          compute;               /* not 0: the compute path, which has no depth, kept and pull */
    glbk_texture phase_surfels[64];     /* surfels of each phase (core path) */
} glbk_ism_maps;

GLBK_DEF glbk_result glbk_ism_maps_create(glbk_context *ctx, const ism_desc *desc, glbk_ism_maps *out);
/* Makes room for the maps of all VPLs, which glbk_ism_maps_free takes back. out->compute says whether they
   are drawn by compute: where ctx->compute is set, unless the surfels of a VPL, rounded up to lazy_frames
   phases, are more than 65,536.
   desc     the desc of the ism_create whose lists are drawn; NULL = all defaults. vpl_count, surfel_count,
            tile_side, projection, lazy_frames, splat_scale, near_point_count, window_rim and no_fill count.
            The other fields, also its system, say how ism.h chooses the lists and play no part here
   out      zeroed on errors
   Memory   on the GPU: 26 bytes for each texel of the atlas, by compute 20, and 16 for each surfel. 1024 VPLs
            with 64 x 64 texels and 8192 surfels take 109 (84) + 134 MB
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL); GLBK_ERR_DESC (a field is out of range); GLBK_ERR_LIMIT
            (the atlas is wider than ctx->max_side); those of programs, textures and targets */
GLBK_DEF void glbk_ism_maps_free(glbk_context *ctx, glbk_ism_maps *maps);
/* Frees what glbk_ism_maps_create made, and zeroes the struct. NULL and zeroed maps are allowed. */

GLBK_DEF glbk_result glbk_ism_mesh_upload(glbk_context *ctx, glbk_ism_maps *maps, const ism_mesh *mesh);
/* Sets what throws shadows. If the number of triangles changes, the surfels of all phases must be given anew.
   mesh     NULL = nothing; its albedos play no part
   Errors   GLBK_ERR_ARGUMENT (NULL, or arrays, counts or strides that do not fit); GLBK_ERR_INPUT (an index
            reaches beyond vertex_count); GLBK_ERR_LIMIT, GLBK_ERR_ALLOC */
GLBK_DEF glbk_result glbk_ism_mesh_move(glbk_context *ctx, glbk_ism_maps *maps, const float *positions,
                                        size_t stride);
/* Sets new places of the same vertices. You may instead render them into the layers of maps->positions, an
   RGBA32F table (docs/gpu-layouts.md). ism.h scatters its surfels over the places that ism_scatter is given
   in any case.
   positions   x, y, z of each of maps->vertex_count vertices
   stride      bytes from one to the next, a multiple of 4, >= 12; 0 = 12
   Errors      GLBK_ERR_ARGUMENT (NULL, or a bad stride), GLBK_ERR_ORDER (there is no mesh), GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_ism_surfels_upload(glbk_context *ctx, glbk_ism_maps *maps, uint32_t phase,
                                             const ism_surfel *surfels, size_t count);
/* Sets the surfels of one phase, of all VPLs, as ism_phase_surfels writes them.
   phase    below lazy_frames. A frame changes the phase index % lazy_frames alone; the first frame needs all
            of them
   surfels  VPL by VPL
   count    surfels of the phase, as ism_phase_surfels counts them: desc.vpl_count x maps->phase_surfel_count
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or there is no such phase. GLBK_ERR_MISMATCH: count is
            another, since ism_create and glbk_ism_maps_create were given different descs */

GLBK_DEF glbk_result glbk_ism_vpls_upload(glbk_context *ctx, glbk_ism_maps *maps, const ism_vpl *vpls,
                                          uint32_t count, const ism_info *info);
/* Sets the VPLs of a frame. They have no near points until glbk_ism_near_points_upload.
   vpls     as ism_vpls has them; area, source, texel and jumped play no part
   count    at most desc.vpl_count; 0 = no light
   info     what ism_get_info writes of the ism_maps whose VPLs these are, after ism_scatter. The maps of
            directional VPLs show the sphere of info->center and info->radius. surfel_count, tile_side and
            lazy_frames must be those of maps->desc; in a struct of your own, for VPLs of your own, they may
            be 0
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_INPUT: a VPL that ism_set_vpls refuses, a negative
            side or reach, a window that leaves nothing of a side, or a radius of 0 beside a directional VPL.
            GLBK_ERR_LIMIT: count is above desc.vpl_count. GLBK_ERR_MISMATCH: info is of an ism_create with
            another desc. GLBK_ERR_ALLOC */
GLBK_DEF glbk_result glbk_ism_near_points_upload(glbk_context *ctx, glbk_ism_maps *maps,
                                                 const ism_near_point *points, uint32_t count);
/* Sets the near points of the VPLs that glbk_ism_vpls_upload was given last, for ISM_NEAR_GATHER, which is
   the default.
   points   as ism_near_points has them
   count    at most desc.vpl_count x desc.near_point_count; 0 = none: ISM_NEAR_GATHER then does what
            ISM_NEAR_PATCH does
   Errors   GLBK_ERR_ARGUMENT (NULL); GLBK_ERR_INPUT (a number is not finite, negative, or that of no VPL);
            GLBK_ERR_LIMIT (too many); GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_ism_draw(glbk_context *ctx, glbk_ism_maps *maps, uint32_t surfels_per_pass);
/* Draws the maps of all VPLs, to maps->atlas: depths, as bits of floats, tile by tile. The core path takes a
   draw for each phase, or for each surfels_per_pass of it, and then up to five passes over the atlas. The
   compute path takes two dispatches. If ctx->max_point_side is below tile_side, the core path draws
   rectangles instead of points.
   surfels_per_pass   most surfels of a draw on the core path; 0 = 2^20. Give fewer if the driver stops draws
                      that take long
   Errors             GLBK_ERR_ARGUMENT (NULL, or maps that were not created); GLBK_ERR_ORDER (the surfels of
                      a phase were not given yet); GLBK_ERR_LOST */

GLBK_DEF glbk_result glbk_ism_bind(glbk_context *ctx, const glbk_ism_maps *maps, const ism_shading *shading,
                                   const glbk_offset *offset);
/* Binds textures and uniform blocks for a program of your own, which is in use (glbk_begin). The program has
   ism_light among its library files, and among its defines ISM_NEAR, the number of a near_mode (0 and 6 are
   ISM_NEAR_GATHER), and ISM_PROJECTION, the number of maps->desc.projection.
   shading  NULL = all defaults; only bias, clamp and no_maps count
   offset   the offset that the part ism has in the program; NULL = none
   Errors   GLBK_ERR_ARGUMENT (NULL, or maps that were not created); GLBK_ERR_DESC (a field of the shading is
            out of range) */

/* ---- ism: complete passes ---- */

typedef struct glbk_ism_renderer {      /* the light of a picture; read only; zeroed = none */
    uint32_t     width;                 /* pixels */
    uint32_t     height;
    glbk_texture light;                 /* irradiance before the blur, GLBK_FORMAT_COLOR, */
    glbk_texture result;                /* and after it */
    glbk_target  light_target;
    glbk_target  result_target;
    glbk_buffer  view;                  /* the uniform block */
    glbk_program shade[ISM_PROJECTION_COUNT][ISM_NEAR_COUNT];   /* compiled at first use */
    glbk_program blur;
    glbk_program resolve;
    int          compute;               /* not 0: light is summed up and blurred by compute */
} glbk_ism_renderer;

GLBK_DEF glbk_result glbk_ism_renderer_create(glbk_context *ctx, uint32_t width, uint32_t height,
                                              glbk_ism_renderer *out);
/* Makes a renderer for pictures of one size, which glbk_ism_renderer_free takes back.
   width    and height: pixels, 1 to ctx->max_side
   out      zeroed on errors
   Memory   on the GPU: 32 bytes for each pixel
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL), GLBK_ERR_DESC (a size is out of range); those of programs,
            textures and targets */
GLBK_DEF void glbk_ism_renderer_free(glbk_context *ctx, glbk_ism_renderer *renderer);
/* Frees what glbk_ism_renderer_create made, and zeroes the struct. NULL and a zeroed renderer are allowed. */

GLBK_DEF glbk_result glbk_ism_shade(glbk_context *ctx, glbk_ism_renderer *renderer,
                                    const glbk_gbuffer *gbuffer, const glbk_ism_maps *maps,
                                    const ism_shading *shading, uint32_t pairs_per_pass);
/* Computes the irradiance of each pixel by all VPLs, as ism_shade does it for receivers without albedos. The
   first use of a near_mode compiles a program.
   gbuffer          the points that are lit, of the renderer's size
   maps             whose maps glbk_ism_draw has drawn, unless shading->no_maps is set
   shading          NULL = all defaults. visible_fn and near_visible_fn must be NULL; cull changes nothing
   pairs_per_pass   how many pairs of a pixel and a VPL one pass takes; 0 = 2^28. Give fewer if the driver
                    stops passes that take long
   Cost             each pixel asks vpl_count / pattern^2 VPLs, a texel of its map for each that faces it
   Errors           GLBK_ERR_ARGUMENT (NULL, or something was not created); GLBK_ERR_DESC (a field of the
                    shading is out of range); GLBK_ERR_MISMATCH (the G-buffer has another size);
                    GLBK_ERR_ORDER (the maps were never drawn); those of glbk_program_compile at first use */
GLBK_DEF glbk_result glbk_ism_resolve(glbk_context *ctx, glbk_ism_renderer *renderer,
                                      const glbk_gbuffer *gbuffer, const glbk_pass *pass,
                                      const glbk_picture *picture);
/* Draws irradiance x albedo / pi, which is linear radiance, to the pass's target. The albedo is the
   G-buffer's diffuse colour, of metal-rough surfaces times 1 - metallic.
   pass     where the picture is drawn and how it is blended; its viewport says where in the target
   picture  whether empty pixels and depths are drawn, see glbk_picture; NULL = every pixel, without depths
   Errors   GLBK_ERR_ARGUMENT (NULL), GLBK_ERR_MISMATCH (the G-buffer has another size); those of
            glbk_begin */
GLBK_DEF glbk_result glbk_ism_read(glbk_context *ctx, const glbk_ism_renderer *renderer, float *rgba);
/* Reads the irradiance, W/m^2, back to the CPU, and waits for the GPU meanwhile.
   rgba     gets 4 floats for each pixel, row 0 of the G-buffer first. The last of four is the irradiance,
            mean of the three channels, that the rule near by took off
   Errors   GLBK_ERR_ARGUMENT (NULL, or a renderer that was not created); GLBK_ERR_LOST */
