/* ---- page one: the light of a sky with its shadows, in a picture that a G-buffer holds ----

   The k shadow maps of a sky's lights lie in one atlas and are drawn by a function of yours. Then one pass
   lights every pixel with all of them (the paper's algorithm 1), or several passes do so with clusters of
   fewer maps (algorithm 2). The lights come from envlights.h or are your own. envshadow.h makes their
   matrices (envsh_maps_create with no_depth) and has the struct that says how the maps are filtered
   (envsh_query). A program makes maps, a G-buffer and a renderer once. A frame:

       envsh_maps_begin(layout, &lights, bounds);              // envshadow.h: the matrices of the views
       glbk_gbuffer_begin(gl, &seen, world_to_clip, eye);      // or glbk_gbuffer_import, or _upload
       glbk_gbuffer_object(gl, &seen, &surface);               // for each object, and your draw
       glbk_envsh_illuminate(gl, &r, &seen, &maps, &frame);
       glbk_envsh_resolve(gl, &r, &seen, &pass, NULL); */

typedef struct glbk_envsh_maps glbk_envsh_maps;         /* the shadow maps of a frame: see below */
typedef struct glbk_envsh_renderer glbk_envsh_renderer; /* the light of a picture: see there */
struct glbk_envsh_maps_desc;        /* how many maps there are, and how large each is */
struct glbk_envsh_renderer_desc;    /* how large the picture is */
struct glbk_envsh_frame;            /* what a frame is lit by, and what casts shadows in it */

GLBK_DEF glbk_result glbk_envsh_maps_create(glbk_context *ctx, const struct glbk_envsh_maps_desc *desc,
                                            glbk_envsh_maps *out);
/* Makes room for shadow maps, which glbk_envsh_maps_free takes back. The tiles lie as square as they can in
   pages of at most ctx->max_side (and 8192) texels a side.
   desc     must be given: its capacity has no default
   out      zeroed on errors
   Memory   on the GPU: 4 bytes for each of map_side^2 x capacity texels; with rgba another 4 for each texel
            of one page; for cells 0.17 for each texel (up to 0.7 if map_side / 8 is no power of two); and 128
            for each light
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range. GLBK_ERR_LIMIT:
            there would be more than ctx->max_layers or 1024 pages, or a tile is larger than ctx->max_side.
            Those of programs, textures and targets */

GLBK_DEF glbk_result glbk_envsh_renderer_create(glbk_context *ctx,
                                                const struct glbk_envsh_renderer_desc *desc,
                                                glbk_envsh_renderer *out);
/* Makes a renderer for pictures of one size, which glbk_envsh_renderer_free takes back.
   out      zeroed on errors
   Memory   on the GPU: 32 bytes for each pixel, by compute 16
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: width or height is 0. GLBK_ERR_LIMIT: width
            or height is above ctx->max_side. Those of programs, textures and targets */

GLBK_DEF glbk_result glbk_envsh_illuminate(glbk_context *ctx, glbk_envsh_renderer *renderer,
                                           const glbk_gbuffer *gbuffer, glbk_envsh_maps *maps,
                                           const struct glbk_envsh_frame *frame);
/* Computes the irradiance of each pixel from all lights of a frame: renders the maps of as many lights as the
   maps hold, adds their light, and goes on with the next ones. That is the paper's algorithm 2, or algorithm
   1 if the maps hold all lights. The sum replaces the light that the renderer has.
   Errors   GLBK_ERR_ARGUMENT: a required pointer is NULL, or an object was not created. Those of
            glbk_envsh_maps_render and glbk_envsh_shade */

typedef glbk_result (*glbk_envsh_draw_fn)(void *user, glbk_context *ctx, glbk_envsh_maps *maps,
                                          uint32_t instances);
/* Draws everything that casts shadows. For each object the function calls glbk_envsh_cast, binds its vertex
   array (with the position where glbk_envsh_maps_desc.attributes says), and draws `instances` instances. It
   returns GLBK_OK; any other result ends the call that renders the maps and is what that call returns. The
   function is called once for each page, with rgba once for each of the four channels of a page, and on
   OpenGL ES that often for each column of tiles. With desc.check of the context it is called twice as often,
   and must draw the same each time. */

GLBK_DEF glbk_result glbk_envsh_cast(glbk_context *ctx, glbk_envsh_maps *maps, const float transform[16]);
/* Sets the matrix of the next object that a glbk_envsh_draw_fn draws. Only such a function may call it.
   transform   object to world, column by column; NULL = identity
   Errors      GLBK_ERR_ARGUMENT: a pointer is NULL, or the maps were not created. GLBK_ERR_LOST */

GLBK_DEF glbk_result glbk_envsh_resolve(glbk_context *ctx, glbk_envsh_renderer *renderer,
                                        const glbk_gbuffer *gbuffer, const glbk_pass *pass,
                                        const glbk_picture *picture);
/* Draws irradiance x albedo / pi, which is linear radiance, to the pass's target. The albedo is the
   G-buffer's diffuse colour, of metal-rough surfaces times 1 - metallic.
   pass     where the picture is drawn and how it is blended; its viewport says where in the target
   picture  whether empty pixels and depths are drawn, see glbk_picture; NULL = every pixel, without depths
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or an object was not created. GLBK_ERR_MISMATCH: the
            G-buffer has another size. Those of glbk_begin */

/* ---- structs of page one ---- */

typedef struct glbk_envsh_renderer_desc {
    uint32_t width;                     /* pixels of the picture, 1 to ctx->max_side; both must be set */
    uint32_t height;
} glbk_envsh_renderer_desc;

typedef struct glbk_envsh_maps_desc {   /* zero it, then set what you care about */
    uint32_t               capacity;    /* how many lights are held at once: all, or a cluster;
                                           1..ENVSH_MAX_LIGHTS */
    const envsh_maps_desc *maps;        /* the desc that envsh_maps_create gets; NULL = all defaults. Here
                                           map_side and guard count, and rgba: four maps share a texel, fewer
                                           pages, four times the draws. Pages are as large as the GPU
                                           allows */
    glbk_attributes        attributes;  /* of casters: position counts, all zero = 0; and your own GLSL */
} glbk_envsh_maps_desc;                 /* maps is read until glbk_envsh_maps_create returns */

struct glbk_envsh_maps {                /* read only; zeroed = none */
    glbk_program cast;                  /* draws casters into the atlas */
    glbk_program make_cells;            /* draws the cells of the atlas */
    glbk_texture atlas;                 /* pages of tiles, a layer each */
    glbk_texture depth;                 /* the depth buffer of a page, with rgba only */
    glbk_texture cells;                 /* least and greatest depths */
    glbk_texture views;                 /* the table of lights */
    glbk_target  atlas_target;
    glbk_target  cell_target;
    glbk_buffer  scene;                 /* the uniform blocks */
    glbk_buffer  query;
    glbk_buffer  object;
    uint32_t     map_side;              /* of the desc with its default, like guard and capacity */
    uint32_t     guard;
    uint32_t     capacity;
    uint32_t     channel_count;         /* maps that share a texel: 1, or 4 with rgba */
    uint32_t     count;                 /* lights whose maps were rendered last; 0 after an error */
    uint32_t     across;                /* columns of tiles of a page */
    uint32_t     down;                  /* rows of tiles of a page */
    uint32_t     page_count;
    uint32_t     cells_side;            /* cells a side of a tile, on the finest level */
    uint32_t     levels;                /* levels of cells */
    uint32_t     first;                 /* private, like step and casts: while casters are drawn, the light
                                           of instance 0 */
    uint32_t     step;                  /* from the light of an instance to that of the next, modulo 2^32 */
    uint32_t     casts;                 /* calls of glbk_envsh_cast */
};

typedef struct glbk_envsh_frame {       /* what a frame is lit by, and what casts shadows in it */
    const envsh_view  *views;           /* of all lights: of an envsh_maps with no_depth and room for all */
    uint32_t           view_count;      /* 0 = no light */
    glbk_envsh_draw_fn draw_fn;         /* draws what casts shadows; required */
    void              *user;            /* given to draw_fn */
    const envsh_query *query;           /* NULL = all defaults; its add plays no part */
} glbk_envsh_frame;

struct glbk_envsh_renderer {            /* read only; zeroed = none */
    glbk_program shade[2 * ENVSH_FILTER_COUNT];     /* by 2 x filter + rgba, compiled at first use */
    glbk_program resolve;
    glbk_texture sums[2];               /* irradiance: one is read while the other is drawn */
    glbk_target  targets[2];
    glbk_buffer  object;                /* the uniform block of the resolve */
    uint32_t     width;                 /* pixels */
    uint32_t     height;
    uint32_t     now;                   /* which of the sums holds the light */
    int          begun;                 /* not 0: the sum holds light */
    int          compute;               /* not 0: there is one sum, which is changed in place */
};
