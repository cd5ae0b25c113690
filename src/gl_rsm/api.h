/* ---- maps ---- */

GLBK_DEF glbk_result glbk_rsm_map_place(glbk_context *ctx, glbk_rsm_map *map, const rsm_light *light);
/* Sets another light, or another place of the same one, for a map that was made. The map must be drawn or
   uploaded anew.
   light    needs as many faces as the map has
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the map was not created. GLBK_ERR_DESC: rsm_map_create
            refuses the light. GLBK_ERR_MISMATCH: the light needs another number of faces */

GLBK_DEF glbk_result glbk_rsm_map_upload(glbk_context *ctx, glbk_rsm_map *map, const rsm_texel *texels);
/* Sets all texels of a map.
   texels   rsm_map_texels of a map of the same light and side: face_count x side x side
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the map was not created. GLBK_ERR_ALLOC */

typedef enum glbk_rsm_color {
    GLBK_RSM_COLOR_DEFAULT,                 /* = GLBK_RSM_COLOR_ALBEDO */
    GLBK_RSM_COLOR_ALBEDO,                  /* linear reflectance: the map's light multiplies it */
    GLBK_RSM_COLOR_FLUX,                    /* W that leave the surface through the texel, as in rsm_texel */
    GLBK_RSM_COLOR_COUNT
} glbk_rsm_color;

typedef struct glbk_rsm_layer {             /* a texture of yours, or a part of it */
    const glbk_texture *texture;            /* NULL = not given. For one that this library has not made, zero
                                               a glbk_texture and set name, width and height; of an array set
                                               layers, of a cube gl_target = GLBK_GL_TEXTURE_CUBE_MAP */
    uint32_t            layer;              /* of an array; else 0 */
} glbk_rsm_layer;

/* A face as your renderer drew it. Textures are either all 2D, or all arrays, or all cubes; not multisampled
   and complete (without mipmaps their filter is GL_NEAREST or GL_LINEAR), and one of depths has no comparison
   mode. 2D textures and layers were drawn as the light sees the face: by the matrix of rsm_map_matrix, or by
   one of yours that looks the same way through the same window. Cubes are asked by directions in world space
   from light.position, as GL draws and shaders read them, so one cube serves all faces of a map. */
typedef struct glbk_rsm_import {
    glbk_rsm_layer      depth;              /* what a depth buffer holds, drawn between near_depth and
                                               far_depth of the map's light; of cubes,
                                               along the axis of the cube's face. depth
                                               or positions is required; with both, depth
                                               only says what is seen */
    glbk_clip_depth     clip_depth;         /* how depths are stored: REVERSED is 1 near .. 0 far, the other
                                               two are 0 near .. 1 far */
    glbk_rsm_layer      positions;          /* floats x, y, z; a 0 in the fourth channel: nothing is seen */
    float               to_world[16];       /* the space of positions and normals to world, a rotation and
                                               translation. All zero = identity */
    glbk_rsm_layer      normals;            /* required, of lengths 0.5..1.5, else nothing is seen; towards
                                               the side that sends light */
    glbk_normal_packing normal_packing;
    glbk_rsm_layer      colors;             /* linear; an sRGB texture is fine */
    glbk_rsm_color      color_kind;         /* what colours are */
    float               color[3];           /* multiplies colors, or counts alone, up to 1e12. All 0 = 1 */
    glbk_rsm_layer      materials;          /* unsigned integers, red: numbers of Phong lobes, as material */
    uint32_t            material;           /* as for glbk_rsm_object; materials replaces it */
    uint32_t            left;               /* where the face begins in 2D textures and layers, in texels, so
                                               that it may be a tile of an atlas */
    uint32_t            bottom;
} glbk_rsm_import;                          /* zero it, then set what you care about */

GLBK_DEF glbk_result glbk_rsm_map_import(glbk_context *ctx, glbk_rsm_renderer *renderer, glbk_rsm_map *map,
                                         uint32_t face, const glbk_rsm_import *import);
/* Fills one face of a map from textures of your own in one pass, as rsm_fill does from arrays. A texel with a
   value that is not finite, or a negative colour, is empty.
   face     below face_count. A map is whole after a call for each
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, an object was not created, or there is no such face.
            GLBK_ERR_DESC: a field is out of range, what is required is missing, textures are of several
            kinds, or there is a cube and the light is a sun. GLBK_ERR_MISMATCH: a cube has not the map's
            side, or a texture ends before the face does. Those of glbk_program_compile at first use */

GLBK_DEF glbk_result glbk_rsm_map_read(glbk_context *ctx, const glbk_rsm_map *map, uint32_t face,
                                       rsm_texel *texels);
/* Reads a face back to the CPU, and waits for the GPU meanwhile. So ism.h can choose VPLs from a map that was
   drawn here.
   face     below face_count
   texels   gets side x side of them, as rsm_map_texels has them
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, the map was not created, or there is no such face.
            GLBK_ERR_ALLOC, GLBK_ERR_LOST */

GLBK_DEF glbk_result glbk_rsm_map_stats(glbk_context *ctx, glbk_rsm_renderer *renderer, glbk_rsm_map *map,
                                        int count, rsm_stats *stats);
/* Counts what rsm_finish counts of a map, in one pass, and reads what was counted.
   count    not 0: counts the map as it is now; nothing waits for that. 0: reads the last count alone, which
            may be of an earlier frame
   stats    receives what was counted, and the call waits for the GPU; NULL = nothing is read. Incident and
            reflected light are sums of floats along rows, of doubles over rows. bad_texels and
            skipped_triangles are 0, since the GPU drops both without a word
   Memory   on the GPU, from the first call on: 48 bytes for each row of texels
   Errors   GLBK_ERR_ARGUMENT: ctx is NULL, or an object was not created. GLBK_ERR_ORDER: count is 0, and
            nothing was counted yet. GLBK_ERR_ALLOC, GLBK_ERR_LOST, those of textures and targets, and those
            of glbk_program_compile at first use */

GLBK_DEF void glbk_rsm_map_free(glbk_context *ctx, glbk_rsm_map *map);
/* Frees what glbk_rsm_map_create made, and zeroes the struct. NULL and a zeroed map are allowed. */

/* ---- the renderer ---- */

GLBK_DEF glbk_result glbk_rsm_renderer_resize(glbk_context *ctx, glbk_rsm_renderer *renderer, uint32_t width,
                                              uint32_t height);
/* Gives the renderer another size, without what it had drawn. Its programs stay, whereas a new renderer would
   compile them anew; so call it when a window has changed its size, with glbk_gbuffer_resize. Its textures
   are new ones.
   Errors   GLBK_ERR_ARGUMENT: the renderer is NULL or was not created. GLBK_ERR_DESC, GLBK_ERR_LIMIT: as for
            glbk_rsm_renderer_create; a renderer that was created with interpolate, and whose member compute
            is set, is refused more than ctx->max_storage / 4 pixels, too. After these it is as it was, after
            those of textures, targets and buffers it is freed and zeroed */

GLBK_DEF void glbk_rsm_renderer_free(glbk_context *ctx, glbk_rsm_renderer *renderer);
/* Frees what glbk_rsm_renderer_create made, and zeroes the struct. NULL and a zeroed renderer are allowed. */

GLBK_DEF glbk_result glbk_rsm_read(glbk_context *ctx, glbk_rsm_renderer *renderer, int bounced, float *rgba);
/* Reads irradiance, W/m^2, back to the CPU, and waits for the GPU meanwhile.
   bounced   not 0: bounced light; 0: direct light
   rgba      gets 4 floats for each pixel, row 0 of the G-buffer first. The last of four says of bounced
             light, before glbk_rsm_denoise: 2 interpolated, above 2 evaluated, 0 nothing is seen
   Errors    GLBK_ERR_ARGUMENT: a pointer is NULL, or the renderer was not created. GLBK_ERR_ORDER: there is
             no such light yet */

/* ---- fewer samples: tables, interpolation, a filter ---- */

GLBK_DEF uint32_t glbk_rsm_point_count(const rsm_gather_desc *desc);
/* Returns how many points the pattern of a desc needs, which is 0 with RSM_PATTERN_FLUX, with a sample_count
   of 0 and for NULL. */

GLBK_DEF glbk_result glbk_rsm_tables_upload(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                            const rsm_gather_desc *desc, const float *points);
/* Sets the tables that glbk_rsm_gather and glbk_rsm_interpolate need for a desc: its noise, its materials,
   and the points of its pattern, all three anew. A desc without any of them needs no call. Otherwise call
   again whenever they change, or pattern, sample_count, interleave, r_min, paper_weights or seed do.
   desc     with at most 1024 materials and a noise_side of at most 1024; NULL = all defaults, which need no
            tables
   points   3 floats each, of rsm_pattern_build(pattern, glbk_rsm_point_count(desc), r_min, paper_weights,
            seed, ..) for the desc; for RSM_PATTERN_MIXED, of RSM_PATTERN_LOG_RADIAL with r_min 1 / 192. NULL
            if the count is 0
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or points are given to a pattern that needs none.
            GLBK_ERR_DESC: a field is out of range. GLBK_ERR_INPUT: a material or noise is out of range.
            GLBK_ERR_LIMIT: a table is too large. GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_rsm_interpolate(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                          const glbk_gbuffer *gbuffer, glbk_rsm_map *const *maps,
                                          uint32_t map_count, const rsm_gather_desc *desc,
                                          const rsm_interpolation *interpolation);
/* Computes bounced light as rsm_interpolate does. First a picture of low resolution is lit, then the pixels
   between its samples are interpolated where three of four samples suit, then finer grids follow, at last
   single pixels. Each step works only where a mask in alpha, or by compute a list, says that pixels are left,
   so nothing is read back from the GPU.
   desc            NULL = all defaults; noise and interleave must be off
   interpolation   NULL = all defaults; its mask must be NULL
   Errors          those of glbk_rsm_gather. GLBK_ERR_MISMATCH: also if the renderer was made without
                   desc.interpolate */

GLBK_DEF glbk_result glbk_rsm_denoise(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                      const glbk_gbuffer *gbuffer, const gifilt_frame *frame,
                                      const glbk_texture *motion);
/* Filters bounced light over frames and neighbours, as gifilt_apply does. Call it once in a frame, after the
   light was gathered. Places and normals of the G-buffer are kept for the next frame.
   frame    NULL = all defaults; its motion must be NULL. Without world_to_clip and motion no pixel is found
            again in the last frame
   motion   where each pixel's surface was in the last frame, in pixels, in r and g; NULL = surfaces that
            moved are new
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or an object was not created. GLBK_ERR_DESC: a field is out
            of range. GLBK_ERR_MISMATCH: the G-buffer has another size, or the renderer was made without
            desc.denoise. GLBK_ERR_ORDER: no light was gathered, or the light was filtered already */

GLBK_DEF void glbk_rsm_reset(glbk_rsm_renderer *renderer);
/* Forgets all frames, so that glbk_rsm_denoise begins anew: for a cut, where no surface of the last frame is
   seen again. NULL is allowed. */

/* ---- shaders of your own ---- */

GLBK_DEF const glbk_part *glbk_rsm_part(void);
/* Returns the GLSL of this header, for programs of your own that use its library files: see
   glbk_source.parts. */

GLBK_DEF void glbk_rsm_bind(glbk_context *ctx, const glbk_rsm_renderer *renderer, const glbk_rsm_map *map,
                            const glbk_offset *offset);
/* Binds textures and uniform blocks for a program of your own, which is in use (glbk_begin) and has
   rsm_direct, rsm_gather or rsm_bounce among its library files. rsm_screen and rsm_bounce read the G-buffer,
   too: they need glbk_gbuffer_bind, and glbk_gbuffer_part() among the parts.
   renderer  its list of lights, as the last glbk_rsm_gather left it, and its tables; NULL = none. By flux,
             without interleave, the list holds the samples of one map after the other: of all maps if they
             are lights_per_pass or fewer, otherwise their last ones. A renderer of 1 x 1 pixels and no
             G-buffer suffice if you want the list alone
   map       its texels and light; NULL = none
   offset    the offset that the part rsm has in the program; NULL = none */
