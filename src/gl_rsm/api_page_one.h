/* ---- page one: lamps that shine on a scene, and the light that bounces off the scene once ---- */

typedef struct glbk_rsm_map glbk_rsm_map;           /* the map of a light: see "objects" below */
typedef struct glbk_rsm_renderer glbk_rsm_renderer; /* the light of a picture: see there, too */
struct glbk_rsm_renderer_desc;      /* how large the picture is: below */

GLBK_DEF glbk_result glbk_rsm_renderer_create(glbk_context *ctx, const struct glbk_rsm_renderer_desc *desc,
                                              glbk_rsm_renderer *out);
/* Makes a renderer for pictures of one size, which glbk_rsm_renderer_free takes back. If ctx->compute is set,
   the renderer gathers and filters by compute.
   out      zeroed on errors
   Memory   on the GPU: 4 MB, and for each pixel 48 bytes, with interpolate 13 more, with denoise 96 more
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range, or a location is
            used twice. GLBK_ERR_LIMIT: width or height is above ctx->max_side. Those of textures and
            targets */

GLBK_DEF glbk_result glbk_rsm_map_create(glbk_context *ctx, const rsm_light *light, uint32_t side,
                                         glbk_rsm_map *out);
/* Makes an empty map of a light, which glbk_rsm_map_free takes back.
   light    as rsm_map_create takes it
   side     texels a side of each face, 4..4096; 0 = 512, of maps with several faces 256
   out      zeroed on errors
   Memory   on the GPU: 60 bytes for each texel
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or side is out of range. GLBK_ERR_DESC: a light that
            rsm_map_create refuses, or an up beyond 1e9. GLBK_ERR_LIMIT, and those of textures and targets */

typedef void (*glbk_rsm_draw_fn)(void *user, glbk_context *ctx, glbk_rsm_renderer *renderer);
/* Draws your scene: for each object the function calls glbk_rsm_object, binds its vertex array and draws.
   Attributes are where glbk_rsm_renderer_desc.attributes says; one that the array has not enabled must be
   zero. Where the normal is zero, the triangle's own counts. */

GLBK_DEF glbk_result glbk_rsm_map_draw(glbk_context *ctx, glbk_rsm_renderer *renderer, glbk_rsm_map *map,
                                       glbk_rsm_draw_fn draw_fn, void *user);
/* Draws a map: place, normal and flux of what its light shines on. Both sides of triangles are drawn, with
   normals turned to the light.
   draw_fn  draws your scene; it is called once for each face, and user is given to it
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or an object was not created. GLBK_ERR_LOST. The first error
            of glbk_rsm_object, and those of glbk_program_compile at first use */

GLBK_DEF glbk_result glbk_rsm_gather(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                     const glbk_gbuffer *gbuffer, glbk_rsm_map *const *maps,
                                     uint32_t map_count, const rsm_gather_desc *desc);
/* Computes the bounced light of each pixel by all maps, from the samples that rsm_gather takes for the same
   desc. This light replaces the bounced light that the renderer has.
   gbuffer  the points that are lit; NULL = no pixels: only the list of lights by flux is made, for shaders of
            your own (glbk_rsm_bind)
   maps     that were drawn or uploaded; map_count at least 1. Running sums of their flux are made if they are
            needed
   desc     NULL = all defaults: every texel is a light. Noise, materials and patterns about the receiver need
            the tables of this desc (glbk_rsm_tables_upload). A program of your own needs RSM_SURFACES=1 among
            its defines for near_field
   Cost     grows with pixels and samples, in passes of lights_per_pass lights
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, map_count is 0, or an object was not created. GLBK_ERR_DESC:
            a field is out of range, or GL cannot honour it. GLBK_ERR_MISMATCH: glbk_rsm_tables_upload was not
            given this desc last, or the G-buffer has another size. Those of glbk_program_compile at first
            use */

GLBK_DEF glbk_result glbk_rsm_object(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                     const glbk_surface *surface, uint32_t material);
/* Sets the surface of the next object that a glbk_rsm_draw_fn draws. Only such a function may call it. The
   first error of such calls is also what glbk_rsm_map_draw returns.
   surface   as for glbk_gbuffer_object. A map takes its transform, its diffuse colour (of metal-rough ones
             times 1 - metallic), color_map, alpha and alpha_cutoff; alpha is that of the colour map at full
             size. Sample the colour map with GLBK_SAMPLING_MIPMAPS, so that flux is filtered (section 6)
   material  number of a Phong lobe of rsm_gather_desc.materials that its texels have, from 1; 0 = none
   Errors    GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_ORDER: the call does not come from a
             glbk_rsm_draw_fn */

GLBK_DEF glbk_result glbk_rsm_direct(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                     const glbk_gbuffer *gbuffer, const glbk_rsm_map *const *maps,
                                     uint32_t map_count, const rsm_direct_desc *desc);
/* Computes the direct light of each pixel: that of the lights of all maps, each shadowed by its own map. This
   light replaces the direct light that the renderer has.
   gbuffer    the points that are lit, of the renderer's size, as in all calls that follow
   maps       that were drawn or uploaded; map_count at least 1, one pass for each
   desc       as rsm_direct takes it; NULL = all defaults
   Errors     GLBK_ERR_ARGUMENT: a pointer is NULL, map_count is 0, or an object was not created.
              GLBK_ERR_DESC: a field is out of range, or GL cannot honour it. GLBK_ERR_MISMATCH: the G-buffer
              has another size. Those of glbk_program_compile at first use */

GLBK_DEF glbk_result glbk_rsm_resolve(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                      const glbk_gbuffer *gbuffer, const glbk_pass *pass,
                                      const glbk_picture *picture, int direct, int bounced);
/* Draws irradiance x albedo / pi, which is linear radiance, to the pass's target. The albedo is the
   G-buffer's diffuse colour, of metal-rough surfaces times 1 - metallic.
   pass      where the picture is drawn and how it is blended; its viewport says where in the target
   picture   whether empty pixels and depths are drawn, see glbk_picture; NULL = every pixel, without depths
   direct    not 0: direct light is shown. Light that was not computed is 0
   bounced   not 0: bounced light is shown
   Errors    GLBK_ERR_ARGUMENT: a pointer is NULL, or an object was not created. GLBK_ERR_MISMATCH: the
             G-buffer has another size. Those of glbk_begin */

/* ---- structs of page one ---- */

typedef struct glbk_rsm_renderer_desc { /* zero it, then set what you care about */
    uint32_t width;                     /* pixels of the picture, 1 to ctx->max_side; both must be set */
    uint32_t height;
    int      interpolate;               /* not 0: makes room for glbk_rsm_interpolate */
    int      denoise;                   /* not 0: makes room for glbk_rsm_denoise */
    uint32_t lights_per_pass;           /* pixel lights that one pass adds up, at most 32768; 0 = 4096. Give
                                           fewer if the driver stops passes that take long */
    glbk_attributes attributes;         /* of meshes that are drawn into maps: position, normal and uv count.
                                           All zero = 0, 1, 2 */
} glbk_rsm_renderer_desc;
