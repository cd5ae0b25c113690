/* ---- rsm: reflective shadow maps, after rsm.h ----

   Lights, descs and their defaults are those of rsm.h, those of the filter are gifilter.h's: the same struct
   gives the same light here and there. What GL cannot honour is an error that names the field
   (GLBK_ERR_DESC): desc.system and desc.add have to be zero, rsm_interpolation.mask and gifilt_frame.motion
   NULL. Maps come from the CPU (rsm_map_texels, as they are), or they are drawn here through a callback of
   yours. Pixel lights are picked by flux, from running sums that are made here, too. A frame:

       glbk_rsm_map_draw(gl, &r, &map, draw, user);               // or glbk_rsm_map_upload
       glbk_gbuffer_begin(gl, &seen, view, eye); ...              // what the camera sees: gl_gbuffer.h
       glbk_rsm_direct(gl, &r, &seen, maps, n, &direct);          // direct light, shadowed by the same maps
       glbk_rsm_gather(gl, &r, &seen, maps, n, &gather);          // bounced light; or glbk_rsm_interpolate
       glbk_rsm_denoise(gl, &r, &seen, &frame, NULL);             // if few samples were taken
       glbk_rsm_resolve(gl, &r, &seen, &pass, NULL, 1, 1);

   Images are RGBA32UI, bits of floats, so that everything works without EXT_color_buffer_float. Shaders of
   your own call functions of lib/rsm_direct.glsl, lib/rsm_gather.glsl and lib/rsm_sampling.glsl, after
   glbk_rsm_bind:

       rsm_light rsm_bound();                      // the light whose map is bound
       rsm_sampling rsm_bound_sampling();          // how glbk_rsm_gather took points last
       vec3 rsm_direct(rsm_light l, vec3 p, vec3 n, int taps, float bias, float slope_bias);
       vec3 rsm_gather_list(rsm_light l, vec3 p, vec3 n, uint from, uint to, bool glossy, float mixed);
       vec3 rsm_gather_about(rsm_light l, vec3 p, vec3 n, rsm_sampling s, vec2 turn, uint first, uint step,
                             uint count);

   p is in world space, n is unit. rsm_direct returns irradiance, W/m^2. The other two return pi times bounced
   irradiance. rsm_gather_list goes through lights from .. to - 1 of the list: all of
   glbk_rsm_frame.first_light to end_light, glossy being glbk_rsm_frame.material_count != 0u and mixed
   glbk_rsm_frame.mixed. rsm_gather_about goes through count points first, first + step, ... of the bound
   pattern about p; turn is cosine and sine of a rotation. */

#define GLBK_RSM_MAP_TEXTURES(X)                                                                        \
    X(usampler2DArray, glbk_rsm_texels, 0)      /* layers 3 face + 0 place, 1 normal, 2 flux */         \
    X(usampler2DArray, glbk_rsm_sums, 1)        /* running sums of flux along rows, */                  \
    X(usampler2DArray, glbk_rsm_rows, 2)        /* and of rows */                                       \
    X(usampler2DArray, glbk_rsm_lights, 3)      /* the list of pixel lights */                          \
    X(sampler2D, glbk_rsm_pattern, 4)                                                                   \
    X(sampler2D, glbk_rsm_noise, 5)                                                                     \
    X(sampler2D, glbk_rsm_materials, 6)

#define GLBK_RSM_PICTURES(X)                                                                            \
    X(glbk_color_sampler, glbk_rsm_sum, 7)      /* light so far; 8 to 11 are the G-buffer's */          \
    X(glbk_color_sampler, glbk_rsm_states, 12)  /* the picture while it is interpolated */              \
    X(glbk_color_sampler, glbk_rsm_coarse, 13)  /* a grid of samples */                                 \
    X(glbk_color_sampler, glbk_rsm_history, 14)                                                         \
    X(usampler2DArray, glbk_rsm_before, 15)     /* place and normal of the last frame */                \
    X(sampler2D, glbk_rsm_motion, 1)            /* these two in programs that read no map */            \
    X(sampler2D, glbk_rsm_albedo_map, 2)

#define GLBK_RSM_TEXTURES(X) GLBK_RSM_MAP_TEXTURES(X) GLBK_RSM_PICTURES(X)

#define GLBK_RSM_LIGHT_FRAME_MEMBERS(X)                                                                 \
    X(vec4, position, 1)            /* w is 1; of the next four 0 */                                    \
    X(vec4, right, 1)               /* frame of face 0 */                                               \
    X(vec4, up, 1)                                                                                      \
    X(vec4, axis, 1)                /* along which light travels */                                     \
    X(vec4, value, 1)               /* as in rsm_light */

#define GLBK_RSM_LIGHT_SHAPE_MEMBERS(X)                                                                 \
    X(float, extent, 1)             /* half a side of the map (sun), or the tangent of that */             \
    X(float, cos_half, 1)           /* cosine of half the cone */                                       \
    X(uint, side, 1)                /* texels a side of a face */                                       \
    X(uint, face_count, 1)                                                                              \
    X(uint, kind, 1)                /* rsm_light_kind */                                                \
    X(uint, unused0, 1)                                                                                 \
    X(uint, unused1, 1)                                                                                 \
    X(uint, unused2, 1)

#define GLBK_RSM_LIGHT_MEMBERS(X) GLBK_RSM_LIGHT_FRAME_MEMBERS(X) GLBK_RSM_LIGHT_SHAPE_MEMBERS(X)

#define GLBK_RSM_LIST_MEMBERS(X)                                                                        \
    X(uint, interleave, 1)          /* pixels a side that share the samples */                          \
    X(uint, point_count, 1)         /* points about the receiver */                                     \
    X(uint, noise_side, 1)          /* texels a side of the noise; 0 = none */                          \
    X(uint, material_count, 1)                                                                          \
    X(uint, first_light, 1)         /* lights of the list: the first, and */                            \
    X(uint, end_light, 1)           /* the one after the last */                                        \
    X(uint, set_room, 1)            /* lights of a set that the list has room for */                    \
    X(uint, adds, 1)                /* not 0: light is added to the sum; 0: the sum begins here */

#define GLBK_RSM_PICK_MEMBERS(X)                                                                        \
    X(uint, seed, 1)                                                                                    \
    X(uint, light_count, 1)         /* lights that are picked from a map */                             \
    X(uint, first_run, 1)           /* number of the first that a pass picks, of each set */            \
    X(uint, taps, 1)                /* of direct light */                                               \
    X(uint, width, 1)               /* of the picture, in pixels */                                     \
    X(uint, height, 1)                                                                                  \
    X(uint, face, 1)                /* of running sums: the face, */                                    \
    X(uint, stride, 1)              /* and how far apart the values are that a step adds up */

#define GLBK_RSM_GRID_MEMBERS(X)                                                                        \
    X(uint, mode, 1)                /* 0: every pixel; 1: nodes of a grid; 2: open pixels */            \
    X(uint, step, 1)                /* pixels from node to node, or from tap to tap of a filter */      \
    X(uint, coarse_step, 1)         /* of the grid before; 0 = there is none */                         \
    X(uint, next_step, 1)           /* of the grid after this; 0 = there is none */                     \
    X(uint, fine_step, 1)           /* compute: of the finest grid */                                   \
    X(uint, list_read, 1)           /* compute: the list that is read, */                               \
    X(uint, list_open, 1)           /* that of pixels that stay open, */                                \
    X(uint, list_wanted, 1)         /* and that of nodes that are wanted */

#define GLBK_RSM_SHOW_MEMBERS(X)                                                                        \
    X(uint, motion, 1)              /* history is found: 0 not, 1 by the last matrix, 2 by a texture */ \
    X(uint, rows_top_first, 1)      /* not 0: the top row of the picture is row 0 */                    \
    X(uint, shows_direct, 1)        /* a resolve shows direct light, */                                 \
    X(uint, shows_bounced, 1)       /* and bounced light */

#define GLBK_RSM_SAMPLING_MEMBERS(X)                                                                    \
    X(float, r_max, 1)              /* these five as in rsm_gather_desc */                              \
    X(float, offset, 1)                                                                                 \
    X(float, clamp_at, 1)                                                                               \
    X(float, near_limit, 1)                                                                             \
    X(float, near_field, 1)                                                                             \
    X(float, set_count, 1)          /* sets of pixels: interleave^2 */                                  \
    X(float, mixed, 1)              /* of RSM_PATTERN_MIXED: its scale, */                              \
    X(float, picked, 1)             /* and how many lights it picks by flux */

#define GLBK_RSM_TEST_MEMBERS(X)                                                                        \
    X(float, bias, 1)               /* these two as in rsm_direct_desc */                               \
    X(float, slope_bias, 1)                                                                             \
    X(float, reach, 1)              /* these five as in rsm_interpolation, or gifilt_frame */           \
    X(float, contrast, 1)                                                                               \
    X(float, normal_cosine, 1)                                                                          \
    X(float, plane_slope, 1)                                                                            \
    X(float, most_distance, 1)                                                                          \
    X(float, history, 1)            /* as in gifilt_frame */

#define GLBK_RSM_FRAME_MEMBERS(X)                                                                       \
    GLBK_RSM_LIST_MEMBERS(X)                                                                            \
    GLBK_RSM_PICK_MEMBERS(X)                                                                            \
    GLBK_RSM_GRID_MEMBERS(X)                                                                            \
    GLBK_RSM_SHOW_MEMBERS(X)                                                                            \
    GLBK_RSM_SAMPLING_MEMBERS(X)                                                                        \
    GLBK_RSM_TEST_MEMBERS(X)

#define GLBK_RSM_OBJECT_MEMBERS(X)                                                                      \
    X(mat4, world, 1)               /* object to world */                                               \
    X(mat4, clip, 1)                /* world to clip space of a face, or of the last frame */           \
    X(vec4, albedo, 1)                                                                                  \
    X(vec4, eye, 1)                 /* where the map is seen from; w = 0: a direction */

#define GLBK_RSM_SURFACE_MEMBERS(X)                                                                     \
    X(float, near_depth, 1)         /* least depth of the map, */                                       \
    X(float, depth_scale, 1)        /* and 1 / its range of depths */                                   \
    X(float, alpha_cutoff, 1)       /* what is less opaque is a hole */                                 \
    X(uint, material, 1)            /* number of a Phong lobe, from 1; 0 = none */                      \
    X(uint, has_map, 1)             /* not 0: glbk_rsm_albedo_map is a factor of the albedo */          \
    X(uint, face, 1)                /* that is drawn */                                                 \
    X(uint, unused0, 1)                                                                                 \
    X(uint, unused1, 1)

#define GLBK_RSM_DRAWN_MEMBERS(X) GLBK_RSM_OBJECT_MEMBERS(X) GLBK_RSM_SURFACE_MEMBERS(X)

#define GLBK_RSM_BLOCKS(X)                                                                              \
    X(glbk_rsm_light, 0, GLBK_RSM_LIGHT_MEMBERS)                                                        \
    X(glbk_rsm_frame, 1, GLBK_RSM_FRAME_MEMBERS)                                                        \
    X(glbk_rsm_drawn, 2, GLBK_RSM_DRAWN_MEMBERS)

#define GLBK_RSM_STORAGE(X)                                                                             \
    X(coherent, uint, glbk_rsm_counts, 0)   /* of each list 4: groups x, y, 1; pixels */                \
    X(readonly, uint, glbk_rsm_items, 1)    /* a list: x | y << 16 */                                   \
    X(writeonly, uint, glbk_rsm_left, 2)    /* the list of pixels that stay open */                     \
    X(writeonly, uint, glbk_rsm_wanted, 3)  /* the list of nodes that are wanted */                     \
    X(coherent, uint, glbk_rsm_marks, 4)    /* a bit for each node of the finest grid */

#define GLBK_RSM_IMAGES(X)                                                                              \
    X(restrict, rgba32f, image2D, glbk_rsm_picture, 0)                                                  \
    X(restrict, rgba32f, image2D, glbk_rsm_nodes, 1)    /* of the finest grid and all before it */      \
    X(restrict writeonly, r32ui, uimage2DArray, glbk_rsm_running, 2)

GLBK__PART(RSM)

GLBK_DEF const glbk_part *glbk_rsm_part(void);
/* Returns the GLSL of this header, for programs of your own that use its library files: see
   glbk_source.parts. */

/* ---- rsm: maps ---- */

typedef struct glbk_rsm_map {           /* the map of a light; read only; zeroed = none */
    uint32_t       side;                /* texels a side of a face */
    uint32_t       face_count;          /* 1, 5 or 6 */
    rsm_light      light;               /* with its defaults */
    glbk_rsm_light block;               /* what shaders know of it */
    glbk_buffer    buffer;              /* that on the GPU */
    glbk_texture   texels;              /* three layers for each face: see glbk_rsm_texels above */
    glbk_texture   depth;
    glbk_texture   sums[2];             /* running sums along rows: one is read while the other is drawn */
    glbk_texture   rows[2];             /* and of rows */
    glbk_target    face_targets[6];
    glbk_target    sum_targets[2][6];
    glbk_target    row_targets[2][6];
    int            summed;              /* not 0: the sums are those of the texels */
    int            sums_at;             /* which of the two holds them */
    int            rows_at;
} glbk_rsm_map;

GLBK_DEF glbk_result glbk_rsm_map_create(glbk_context *ctx, const rsm_light *light, uint32_t side,
                                         glbk_rsm_map *out);
/* Makes an empty map of a light, which glbk_rsm_map_free takes back.
   light    as rsm_map_create takes it
   side     texels a side of each face, 4..4096; 0 = 512, of maps with several faces 256
   out      zeroed on errors
   Memory   on the GPU: 60 bytes for each texel
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL); GLBK_ERR_DESC (what rsm_map_create refuses);
            GLBK_ERR_LIMIT; those of textures and targets */
GLBK_DEF glbk_result glbk_rsm_map_place(glbk_context *ctx, glbk_rsm_map *map, const rsm_light *light);
/* Sets another light, or another place of the same one, for a map that was made. The map must be drawn or
   uploaded anew.
   light    needs as many faces as the map has
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL); GLBK_ERR_DESC (what rsm_map_create refuses);
            GLBK_ERR_MISMATCH (another number of faces) */
GLBK_DEF glbk_result glbk_rsm_map_upload(glbk_context *ctx, glbk_rsm_map *map, const rsm_texel *texels);
/* Sets all texels of a map.
   texels   rsm_map_texels of a map of the same light and side: face_count x side x side
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL, or the map was not created); GLBK_ERR_ALLOC */
GLBK_DEF glbk_result glbk_rsm_map_read(glbk_context *ctx, const glbk_rsm_map *map, uint32_t face,
                                       rsm_texel *texels);
/* Reads a face back to the CPU, and waits for the GPU meanwhile. So ism.h can choose VPLs from a map that was
   drawn here.
   face     below face_count
   texels   gets side x side of them, as rsm_map_texels has them
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL, or there is no such face); GLBK_ERR_ALLOC, GLBK_ERR_LOST */
GLBK_DEF void glbk_rsm_map_free(glbk_context *ctx, glbk_rsm_map *map);
/* Frees what glbk_rsm_map_create made, and zeroes the struct. NULL and a zeroed map are allowed. */

/* ---- rsm: the renderer ---- */

typedef struct glbk_rsm_renderer_desc { /* zero it, then set what you care about */
    uint32_t width;                     /* pixels of the picture, 1 to ctx->max_side; both must be set */
    uint32_t height;
    int      interpolate;               /* not 0: makes room for glbk_rsm_interpolate */
    int      denoise;                   /* not 0: makes room for glbk_rsm_denoise */
    uint32_t lights_per_pass;           /* pixel lights that one pass adds up, at most 32768; 0 = 4096. Give
                                           fewer if the driver stops passes that take long */
} glbk_rsm_renderer_desc;

#define GLBK_RSM_PROGRAM_COUNT 24u

typedef struct glbk_rsm_renderer {      /* the light of a picture; read only; zeroed = none */
    glbk_program    programs[GLBK_RSM_PROGRAM_COUNT];   /* compiled when they are first needed */
    glbk_texture    sums[3];            /* pictures: direct light, bounced light, and one to draw to */
    glbk_texture    grids[3];           /* grids of interpolation; by compute one */
    glbk_texture    history[2];         /* what the filter remembers of light, */
    glbk_texture    kept[2];            /* and of what was seen with it */
    glbk_texture    lights;             /* the list of pixel lights */
    glbk_target     targets[3];         /* of sums, */
    glbk_target     grid_targets[3];    /* of grids, */
    glbk_target     history_targets[2]; /* of history and kept, */
    glbk_target     lights_target;      /* of lights */
    glbk_texture    pattern;            /* tables of glbk_rsm_tables_upload */
    glbk_texture    noise;
    glbk_texture    materials;
    rsm_gather_desc tables;             /* what these three are made of, without its pointers */
    uint32_t        point_count;        /* points of the pattern */
    uint32_t        noise_side;         /* texels a side of the noise; 0 = none */
    uint32_t        material_count;
    glbk_buffer     frame;              /* uniform blocks: of passes, */
    glbk_buffer     object;             /* of objects that are drawn */
    glbk_rsm_frame  values;             /* what they hold, or will hold */
    glbk_rsm_drawn  drawn;
    float           before[16];         /* world to clip space of the last frame */
    uint32_t        width;
    uint32_t        height;
    uint32_t        lights_per_pass;
    uint32_t        direct;             /* which of sums holds direct light; 9 = none */
    uint32_t        bounce;             /* which holds bounced light, 3 and 4 being history; 9 = none */
    uint32_t        remembers;          /* 1 + which history is the newest; 0 = none */
    int             has_before;         /* not 0: before is set */
    int             drawing;            /* not 0: within a glbk_rsm_draw_fn */
    int             filtered;           /* not 0: bounced light was filtered */
    glbk_result     failed;             /* the first error of glbk_rsm_object while drawing */
    int             compute;            /* not 0: gathering and filtering are done by compute */
    glbk_buffer     counts;             /* then, with interpolate, lists of pixels: how long they are, */
    glbk_buffer     open[2];            /* pixels that stay open, */
    glbk_buffer     wanted;             /* nodes that are wanted, */
    glbk_buffer     marks;              /* and a bit for each node that was */
} glbk_rsm_renderer;

GLBK_DEF glbk_result glbk_rsm_renderer_create(glbk_context *ctx, const glbk_rsm_renderer_desc *desc,
                                              glbk_rsm_renderer *out);
/* Makes a renderer for pictures of one size, which glbk_rsm_renderer_free takes back. If ctx->compute is set,
   it gathers and filters by compute.
   desc     must be given
   out      zeroed on errors
   Memory   on the GPU: 4 MB, and for each pixel 48 bytes, with interpolate 13 more, with denoise 96 more
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL), GLBK_ERR_DESC (a field is out of range), GLBK_ERR_LIMIT;
            those of textures and targets */
GLBK_DEF void glbk_rsm_renderer_free(glbk_context *ctx, glbk_rsm_renderer *renderer);
/* Frees what glbk_rsm_renderer_create made, and zeroes the struct. NULL and a zeroed renderer are allowed. */

GLBK_DEF uint32_t glbk_rsm_point_count(const rsm_gather_desc *desc);
/* Returns how many points the pattern of a desc needs: 0 with RSM_PATTERN_FLUX or samples 0, and for NULL. */
GLBK_DEF glbk_result glbk_rsm_tables_upload(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                            const rsm_gather_desc *desc, const float *points);
/* Sets the tables that glbk_rsm_gather and glbk_rsm_interpolate need for a desc: its noise, its materials,
   and the points of its pattern, all three anew. A desc without any of them needs no call. Otherwise call
   again whenever they change, or pattern, samples, interleave, r_min, paper_weights or seed do.
   desc     with at most 1024 materials and a noise_side of at most 1024; NULL = all defaults, which need no
            tables
   points   3 floats each, of rsm_pattern_build(pattern, glbk_rsm_point_count(desc), r_min, paper_weights,
            seed, ..) for the desc; for RSM_PATTERN_MIXED, of RSM_PATTERN_LOG_RADIAL with r_min 1 / 192. NULL
            if the count is 0
   Errors   GLBK_ERR_ARGUMENT (NULL, or points that do not go with the pattern); GLBK_ERR_DESC (a field is out
            of range); GLBK_ERR_LIMIT (a table is too large); GLBK_ERR_ALLOC */

/* ---- rsm: drawing maps ---- */

typedef void (*glbk_rsm_draw_fn)(void *user, glbk_context *ctx, glbk_rsm_renderer *renderer);
/* Draws your scene. For each object it calls glbk_rsm_object, binds its vertex array and draws. Attributes
   are 0 position, 1 normal, 2 texture coordinates; one that the array has not enabled must be zero. Where the
   normal is zero, the triangle's own counts. */

GLBK_DEF glbk_result glbk_rsm_object(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                     const glbk_surface *surface, uint32_t material);
/* Sets the surface of the next object that a glbk_rsm_draw_fn draws. Only such a function may call it. The
   first error of such calls is also what glbk_rsm_map_draw returns.
   surface   as for glbk_gbuffer_object. A map takes its world, its diffuse colour (of metal-rough ones times
             1 - metallic), color_map, alpha and alpha_cutoff; alpha is that of the colour map at full size.
             Sample the colour map with GLBK_SAMPLING_MIPMAPS, so that flux is filtered (section 6)
   material  number of a Phong lobe of rsm_gather_desc.materials that its texels have, from 1; 0 = none
   Errors    GLBK_ERR_ARGUMENT (a pointer is NULL), GLBK_ERR_ORDER (the call does not come from a
             glbk_rsm_draw_fn) */

GLBK_DEF glbk_result glbk_rsm_map_draw(glbk_context *ctx, glbk_rsm_renderer *renderer, glbk_rsm_map *map,
                                       glbk_rsm_draw_fn draw_fn, void *user);
/* Draws a map: place, normal and flux of what its light shines on. Both sides of triangles are drawn, with
   normals turned to the light.
   draw_fn  draws your scene; it is called once for each face, and user is given to it
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL, or something was not created); the first of glbk_rsm_object;
            those of glbk_program_compile at first use; GLBK_ERR_LOST */

/* ---- rsm: light ---- */

GLBK_DEF glbk_result glbk_rsm_direct(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                     const glbk_gbuffer *gbuffer, const glbk_rsm_map *const *maps,
                                     uint32_t map_count, const rsm_direct_desc *desc);
/* Computes the direct light of each pixel: that of the lights of all maps, each shadowed by its own map. It
   takes the place of the direct light that the renderer has.
   gbuffer    the points that are lit, of the renderer's size, here and below
   maps       that were drawn or uploaded; map_count at least 1, one pass for each
   desc       as rsm_direct takes it; NULL = all defaults
   Errors     GLBK_ERR_ARGUMENT (NULL, no map, or something was not created); GLBK_ERR_DESC (a field is out of
              range, or one that GL cannot honour); GLBK_ERR_MISMATCH (the G-buffer has another size); those
              of glbk_program_compile at first use */

GLBK_DEF glbk_result glbk_rsm_gather(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                     const glbk_gbuffer *gbuffer, glbk_rsm_map *const *maps,
                                     uint32_t map_count, const rsm_gather_desc *desc);
/* Computes the bounced light of each pixel by all maps, from the samples that rsm_gather takes for the same
   desc. It takes the place of the bounced light that the renderer has.
   gbuffer  the points that are lit; NULL = no pixels: only the list of lights by flux is made, for shaders of
            your own (glbk_rsm_bind)
   maps     that were drawn or uploaded; map_count at least 1. Running sums of their flux are made if they are
            needed
   desc     NULL = all defaults: every texel is a light. Noise, materials and patterns about the receiver need
            the tables of this desc (glbk_rsm_tables_upload). A program of your own needs RSM_SURFACES=1 among
            its defines for near_field
   Cost     grows with pixels and samples, in passes of lights_per_pass lights
   Errors   GLBK_ERR_ARGUMENT (NULL, no map, or something was not created); GLBK_ERR_DESC (a field is out of
            range, or one that GL cannot honour); GLBK_ERR_MISMATCH (glbk_rsm_tables_upload was not given this
            desc last, or the G-buffer has another size); those of glbk_program_compile at first use */

GLBK_DEF glbk_result glbk_rsm_interpolate(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                          const glbk_gbuffer *gbuffer, glbk_rsm_map *const *maps,
                                          uint32_t map_count, const rsm_gather_desc *desc,
                                          const rsm_interpolation *interpolation);
/* Computes bounced light as rsm_interpolate does. First a picture of low resolution is lit, then the pixels
   between its samples are interpolated where three of four samples suit, then finer grids follow, at last
   single pixels. Each step works only where a mask in alpha, or by compute a list, says that something is
   left, so nothing is read back from the GPU.
   desc            NULL = all defaults; noise and interleave must be off
   interpolation   NULL = all defaults; its mask must be NULL
   Errors          as of glbk_rsm_gather; GLBK_ERR_ORDER (the renderer was made without desc.interpolate) */

GLBK_DEF glbk_result glbk_rsm_denoise(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                      const glbk_gbuffer *gbuffer, const gifilt_frame *frame,
                                      const glbk_texture *motion);
/* Filters bounced light over frames and neighbours, as gifilt_apply does. Call it once in a frame, after the
   light was gathered. Places and normals of the G-buffer are kept for the next frame.
   frame    NULL = all defaults; its motion must be NULL. Without view_projection and motion nothing is found
            again
   motion   where each pixel's surface was in the last frame, in pixels, in r and g; NULL = surfaces that
            moved are new
   Errors   GLBK_ERR_ARGUMENT (NULL, or something was not created); GLBK_ERR_DESC (a field is out of range);
            GLBK_ERR_MISMATCH (the G-buffer has another size); GLBK_ERR_ORDER (nothing was gathered, or it was
            filtered already, or the renderer was made without desc.denoise) */
GLBK_DEF void glbk_rsm_reset(glbk_rsm_renderer *renderer);
/* Forgets all frames, so that glbk_rsm_denoise begins anew: for a cut, where nothing of the last frame is
   seen again. NULL is allowed. */

GLBK_DEF glbk_result glbk_rsm_resolve(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                      const glbk_gbuffer *gbuffer, const glbk_pass *pass,
                                      const glbk_picture *picture, int direct, int bounced);
/* Draws irradiance x albedo / pi, which is linear radiance, to the pass's target. The albedo is the
   G-buffer's diffuse colour, of metal-rough surfaces times 1 - metallic.
   pass      where the picture is drawn and how it is blended; its viewport says where in the target
   picture   whether empty pixels and depths are drawn, see glbk_picture; NULL = every pixel, without depths
   direct    not 0: shows direct light; bounced: not 0: shows bounced light. Light that was not computed is 0
   Errors    GLBK_ERR_ARGUMENT (NULL), GLBK_ERR_MISMATCH (the G-buffer has another size); those of
             glbk_begin */

GLBK_DEF glbk_result glbk_rsm_read(glbk_context *ctx, glbk_rsm_renderer *renderer, int bounced, float *rgba);
/* Reads irradiance, W/m^2, back to the CPU, and waits for the GPU meanwhile.
   bounced   not 0: bounced light; 0: direct light
   rgba      gets 4 floats for each pixel, row 0 of the G-buffer first. The last of four says of bounced
             light, before glbk_rsm_denoise: 2 interpolated, above 2 evaluated, 0 nothing is seen
   Errors    GLBK_ERR_ARGUMENT (NULL, or a renderer that was not created), GLBK_ERR_ORDER (there is no such
             light yet) */

GLBK_DEF void glbk_rsm_bind(glbk_context *ctx, const glbk_rsm_renderer *renderer, const glbk_rsm_map *map,
                            const glbk_offset *offset);
/* Binds textures and uniform blocks for a program of your own, which is in use (glbk_begin) and has
   rsm_direct, rsm_gather or rsm_bounce among its library files. rsm_screen and rsm_bounce read the G-buffer,
   too: glbk_gbuffer_bind, and glbk_gbuffer_part() among the parts.
   renderer  its list of lights, as the last glbk_rsm_gather left it, and its tables; NULL = none. By flux,
             without interleave, the list holds the samples of one map after the other: of all maps if they
             are lights_per_pass or fewer, otherwise their last ones. A renderer of 1 x 1 pixels and no
             G-buffer suffice if you want the list alone
   map       its texels and light; NULL = none
   offset    the offset that the part rsm has in the program; NULL = none */
