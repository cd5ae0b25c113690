/* ---- envsh: environment-map shadows, after envshadow.h ----

   k shadow maps in one atlas, drawn through your callback, then one pass that lights every pixel with all of them (the
   paper's algorithm 1), or clusters of fewer maps and several passes (algorithm 2). Lights come from envlights.h or are
   your own; envshadow.h makes their matrices (envsh_maps_create with no_depth), and its envsh_query says how the maps
   are asked. docs/gpu-layouts.md has the layouts. For shaders of your own, lib/envsh_light.glsl with glbk_envsh_bind:

       vec3 envsh_light(vec3 p, vec3 n, vec3 flat_n, uint index);         // irradiance of all lights, W/m^2
       float envsh_visible(envsh_query q, uint light, vec3 p, vec3 n, uint index);    // 0..1; q: envsh_bound_query()

   World space, unit normals on the side that is seen: n for shading, flat_n (n of envsh_visible) the surface's own;
   index: another for each pixel, it turns the taps. envsh_direction(light): unit, to it; envsh_power(light): W/m^2. */

#define GLBK_ENVSH_TEXTURES(X)                                                                      \
    X(sampler2DArray, glbk_envsh_depth, 0)      /* the atlas: depth, or */                          \
    X(usampler2DArray, glbk_envsh_depth4, 1)    /* the bits of four maps' depths */                 \
    X(usampler2DArray, glbk_envsh_cells, 2)     /* least and greatest depth of cells, as bits */    \
    X(usampler2DArray, glbk_envsh_views, 3)     /* lights */                                        \
    X(glbk_color_sampler, glbk_envsh_sum, 4)

#define GLBK_ENVSH_SCENE_MEMBERS(X)                                                                 \
    X(uvec4, tiles, 1)          /* texels a side, guard, maps a texel, cells a side */              \
    X(uvec4, range, 1)          /* lights; levels of cells */                                       \
    X(vec4, page, 1)            /* 2 / width, 2 / height of a page, 2 / inside of a tile */

#define GLBK_ENVSH_QUERY_MEMBERS(X)                                                                 \
    X(vec4, values, 1)          /* radius, bias, extent_scale */                                    \
    X(uvec4, numbers, 1)        /* taps, seed */                                                    \
    X(uvec4, range, 1)          /* lights from, to; width; 0 = the sum begins here */               \
    X(vec4, disc, 32)           /* two taps each */

#define GLBK_ENVSH_OBJECT_MEMBERS(X)                                                                \
    X(mat4, world, 1)                                                                               \
    X(uvec4, lights, 1)         /* casting: first light, step; cells: job; resolving: corner, lit */

#define GLBK_ENVSH_BLOCKS(X)                                \
    X(glbk_envsh_scene, 0, GLBK_ENVSH_SCENE_MEMBERS)        \
    X(glbk_envsh_query, 1, GLBK_ENVSH_QUERY_MEMBERS)        \
    X(glbk_envsh_object, 2, GLBK_ENVSH_OBJECT_MEMBERS)

#define GLBK_ENVSH_STORAGE(X)
#define GLBK_ENVSH_IMAGES(X)    X(restrict, rgba32f, image2D, glbk_envsh_total, 0)   /* the sum, by compute */

GLBK__PART(ENVSH)

GLBK_DEF const glbk_part *glbk_envsh_part(void);
/* The GLSL of this header, for programs of your own that use its library files: glbk_source.parts. */

typedef struct glbk_envsh_maps_desc {
    uint32_t    capacity;       /* lights held at once, 1..ENVSH_MAX_LIGHTS: all k, or a cluster of c */
    uint32_t    map_side;       /* texels a side of a tile, as in envsh_maps_desc, 16..4096; 0 = 256 */
    uint32_t    guard;          /* as there, 1..map_side / 4; 0 = 4 */
    int         rgba;           /* not 0: four maps share a texel: a quarter of the pages, four rounds of drawing */
    const char *vertex;         /* both NULL; or your own shaders for what casts shadows (skinning, alpha masks), */
    const char *fragment;       /* made as lib/envsh_cast.glsl says */
} glbk_envsh_maps_desc;         /* zero it, then set what you care about */

typedef struct glbk_envsh_maps {        /* read only; zeroed = none */
    glbk_program cast, make_cells;
    glbk_texture atlas, depth, cells, views;    /* depth: with rgba only */
    glbk_target  atlas_target, cell_target;
    glbk_buffer  scene, query, object;
    uint32_t     map_side, guard, channels, capacity, count;
    uint32_t     across, down, pages, cells_wide, levels;
    uint32_t     first, step;           /* while casting: the instances' lights */
    uint32_t     casts;                 /* while casting: calls of glbk_envsh_cast */
} glbk_envsh_maps;

GLBK_DEF glbk_result glbk_envsh_maps_create(glbk_context *ctx, const glbk_envsh_maps_desc *desc, glbk_envsh_maps *out);
/* Tiles lie as square as may be in pages of at most ctx->max_side texels a side, pages are layers of a texture.
   Memory on the GPU: 4 bytes a texel of map_side^2 x capacity (rgba: and 4 bytes a texel of a page), an eighth for
   cells (a sixth where map_side / 8 is no power of two), 128 bytes a light.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, a field out of range; GLBK_ERR_LIMIT where pages pass ctx->max_layers or
            1024; those of programs and textures */
GLBK_DEF void glbk_envsh_maps_free(glbk_context *ctx, glbk_envsh_maps *maps);

typedef glbk_result (*glbk_envsh_draw_fn)(void *user, glbk_context *ctx, glbk_envsh_maps *maps, uint32_t instances);
/* Draws everything that casts shadows, each object by one call: glbk_envsh_cast, your vertex array (attribute 0 is the
   position), then an instanced draw with that many instances. What it returns ends the pass where it is not GLBK_OK.
   It is called once for each page, with rgba once for each channel of it, on ES once for each column of tiles. */

GLBK_DEF glbk_result glbk_envsh_cast(glbk_context *ctx, glbk_envsh_maps *maps, const float world[16]);
/* Inside glbk_envsh_draw_fn: the matrix of the next object; NULL = identity. */

GLBK_DEF glbk_result glbk_envsh_maps_render(glbk_context *ctx, glbk_envsh_maps *maps, const envsh_view *views,
                                            uint32_t count, glbk_envsh_draw_fn draw_fn, void *user);
/* The shadow maps of a frame.
   views   of envsh_get_views, at most the capacity; where their tiles lie is not looked at. envsh_maps_desc had
           the map_side of desc as its map_side, and the same guard
   Errors  GLBK_ERR_ARGUMENT; GLBK_ERR_MISMATCH: views for tiles of another size or guard; with desc.check, which
           reads the maps back, GLBK_ERR_ORDER: draw_fn never called glbk_envsh_cast, or did not draw as many instances
           as it was given; what draw_fn returned */

GLBK_DEF glbk_result glbk_envsh_bind(glbk_context *ctx, glbk_envsh_maps *maps, const envsh_query *query,
                                     const glbk_offset *offset);
/* For a program of yours with envsh_light among its library files and ENVSH_FILTER=query->filter and ENVSH_RGBA=0 or 1
   among its defines, which is bound: textures and uniform blocks.
   query    NULL = all defaults
   offset   that envsh has in the program; NULL = none
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, a field out of range */

/* ---- envsh: complete passes ----

   Once glbk_envsh_maps_create, glbk_gbuffer_create (gl_gbuffer.h) and glbk_envsh_renderer_create. A frame:

       envsh_maps_begin(layout, &lights, bounds);                         // envshadow.h: matrices of the views
       glbk_gbuffer_begin(gl, &seen, world_to_clip, eye);                 // or _import, or _upload
       glbk_gbuffer_object(gl, &seen, &surface);                          // of each object, and your draw
       glbk_envsh_illuminate(gl, &r, &seen, &maps, &frame);
       glbk_envsh_resolve(gl, &r, &seen, &pass, NULL);

   glbk_envsh_maps_render and glbk_envsh_shade are the two halves of glbk_envsh_illuminate. Where ctx->compute, the
   compute path is taken. */

typedef struct glbk_envsh_renderer {    /* read only; zeroed = none */
    glbk_program shade[2 * ENVSH_FILTER_COUNT], resolve;        /* shade: by filter and rgba */
    glbk_texture sums[2];
    glbk_target  targets[2];
    glbk_buffer  object;
    uint32_t     width, height, now;
    int          begun;                 /* the sum holds light */
    int          compute;               /* one sum, changed in place */
} glbk_envsh_renderer;

GLBK_DEF glbk_result glbk_envsh_renderer_create(glbk_context *ctx, uint32_t width, uint32_t height,
                                                glbk_envsh_renderer *out);
GLBK_DEF void glbk_envsh_renderer_free(glbk_context *ctx, glbk_envsh_renderer *renderer);

GLBK_DEF glbk_result glbk_envsh_shade(glbk_context *ctx, glbk_envsh_renderer *renderer, const glbk_gbuffer *gbuffer,
                                      glbk_envsh_maps *maps, const envsh_query *query, uint32_t lights_per_pass);
/* Light of all maps that were rendered, to the sum of each pixel; query->add: to the sum as it is. The first use of a
   filter compiles a program.
   gbuffer          of the renderer's size
   query            NULL = all defaults
   lights_per_pass  0 = all in one pass, as the paper has it; fewer where a driver's patience is short
   Errors           GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, a field of the query; GLBK_ERR_MISMATCH, another size; those of
                    glbk_program_create at first use */

typedef struct glbk_envsh_frame {       /* what is lit by, and what casts shadows */
    const envsh_view  *views;           /* of all lights, by envsh_maps_create with no_depth and a capacity of count */
    uint32_t           view_count;
    glbk_envsh_draw_fn draw_fn;         /* required */
    void              *user;            /* given to draw_fn */
    const envsh_query *query;           /* NULL = all defaults; its add is not looked at */
} glbk_envsh_frame;

GLBK_DEF glbk_result glbk_envsh_illuminate(glbk_context *ctx, glbk_envsh_renderer *renderer,
                                           const glbk_gbuffer *gbuffer, glbk_envsh_maps *maps,
                                           const glbk_envsh_frame *frame);
/* The paper's algorithm 2 in clusters of the maps' capacity, or 1 where that holds all lights: renders their maps and
   adds their light. Errors: those of glbk_envsh_maps_render and glbk_envsh_shade */

GLBK_DEF glbk_result glbk_envsh_resolve(glbk_context *ctx, glbk_envsh_renderer *renderer, const glbk_gbuffer *gbuffer,
                                        const glbk_pass *pass, const glbk_picture *picture);
/* Draws irradiance x albedo / pi, linear radiance, to the pass's target; viewports: see glbk_pass. Of metal-rough
   surfaces the albedo is that of what is no metal.
   picture  or NULL, see glbk_picture
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_MISMATCH; those of glbk_begin */
GLBK_DEF glbk_result glbk_envsh_read(glbk_context *ctx, glbk_envsh_renderer *renderer, float *rgba);
/* The irradiance: 4 floats a pixel, the last one 0. Waits for the GPU. */
