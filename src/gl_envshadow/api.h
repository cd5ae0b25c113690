/* ---- envsh: environment-map shadows, after envshadow.h ----

   The k shadow maps of a sky's lights lie in one atlas and are drawn through your callback. Then one pass
   lights every pixel with all of them (the paper's algorithm 1), or several passes do so with clusters of
   fewer maps (algorithm 2). The lights come from envlights.h or are your own. envshadow.h makes their
   matrices (envsh_maps_create with no_depth) and has the struct that says how the maps are filtered
   (envsh_query). docs/gpu-layouts.md describes all textures and blocks. Shaders of your own call these
   functions of lib/envsh_light.glsl, after glbk_envsh_bind:

       vec3 envsh_light(vec3 p, vec3 n, vec3 flat_n, uint index);  // irradiance by all lights, W/m^2
       float envsh_visible(envsh_query q, uint light, vec3 p, vec3 n, uint index);     // 0 hidden .. 1 seen
       envsh_query envsh_bound_query();                            // the query that was bound
       vec3 envsh_direction(uint light);                           // unit, to the light
       vec3 envsh_power(uint light);                               // its irradiance where it is faced, W/m^2

   p is a point in world space. Normals are unit and on the side that is seen: n of envsh_light is the shading
   normal, flat_n and n of envsh_visible are the surface's own. index turns the pattern of taps: give each
   pixel another one. glbk_envsh_scene.light_count is the number of lights. */

#define GLBK_ENVSH_TEXTURES(X)                                                                      \
    X(sampler2DArray, glbk_envsh_depth, 0)      /* the atlas: depths, or */                         \
    X(usampler2DArray, glbk_envsh_depth4, 1)    /* the bits of four maps' depths */                 \
    X(usampler2DArray, glbk_envsh_cells, 2)     /* least and greatest depth of cells, as bits */    \
    X(usampler2DArray, glbk_envsh_views, 3)     /* the table of lights */                           \
    X(glbk_color_sampler, glbk_envsh_sum, 4)    /* irradiance so far */

#define GLBK_ENVSH_SCENE_MEMBERS(X)                                                                 \
    X(uint, map_side, 1)            /* texels a side of a tile */                                   \
    X(uint, guard, 1)               /* texels at each side of a tile that stay empty */             \
    X(uint, cells_side, 1)          /* cells a side of a tile, on the finest level */               \
    X(uint, level_count, 1)         /* levels of cells */                                           \
    X(uint, light_count, 1)         /* lights whose maps were rendered last */                      \
    X(float, clip_per_inside, 1)    /* 2 / texels a side of a tile without its guard */             \
    X(float, clip_per_texel_x, 1)   /* 2 / texels of a page, along x, */                            \
    X(float, clip_per_texel_y, 1)   /* and along y */

#define GLBK_ENVSH_QUERY_MEMBERS(X)                                                                 \
    X(float, radius, 1)             /* these five as in envsh_query, with its defaults */           \
    X(float, bias, 1)                                                                               \
    X(float, extent_scale, 1)                                                                       \
    X(uint, taps, 1)                                                                                \
    X(uint, seed, 1)                                                                                \
    X(uint, first_light, 1)         /* the lights of a pass: the first, and */                      \
    X(uint, end_light, 1)           /* the one after the last */                                    \
    X(uint, adds, 1)                /* not 0: their light is added to the sum; 0: it begins here */ \
    X(vec4, disc, 32)               /* the taps on the unit disc, two in each */

#define GLBK_ENVSH_OBJECT_MEMBERS(X)                                                                \
    X(mat4, world, 1)               /* of a caster: object to world */                              \
    X(uint, first_light, 1)         /* the light of instance 0, and */                              \
    X(uint, light_step, 1)          /* how much farther on that of the next instance is */          \
    X(uint, level, 1)               /* of cells that are made: their level */                       \
    X(uint, layer, 1)               /* and layer */                                                 \
    X(uint, lit, 1)                 /* of a resolve: not 0 if the sum holds light */                \
    X(uint, unused0, 1)                                                                             \
    X(uint, unused1, 1)                                                                             \
    X(uint, unused2, 1)

#define GLBK_ENVSH_BLOCKS(X)                                \
    X(glbk_envsh_scene, 0, GLBK_ENVSH_SCENE_MEMBERS)        \
    X(glbk_envsh_query, 1, GLBK_ENVSH_QUERY_MEMBERS)        \
    X(glbk_envsh_object, 2, GLBK_ENVSH_OBJECT_MEMBERS)

#define GLBK_ENVSH_STORAGE(X)
#define GLBK_ENVSH_IMAGES(X)    X(restrict, rgba32f, image2D, glbk_envsh_total, 0)   /* the sum, by compute */

GLBK__PART(ENVSH)

GLBK_DEF const glbk_part *glbk_envsh_part(void);
/* Returns the GLSL of this header, for programs of your own that use its library files: see
   glbk_source.parts. */

typedef struct glbk_envsh_maps_desc {   /* zero it, then set what you care about */
    uint32_t    capacity;       /* how many lights are held at once: all, or a cluster; 1..ENVSH_MAX_LIGHTS */
    uint32_t    map_side;       /* texels a side of a tile, 16..4096, as in envsh_maps_desc; 0 = 256 */
    uint32_t    guard;          /* texels at each side of a tile that stay empty, 1..map_side / 4, the same
                                   as there; 0 = 4 */
    int         rgba;           /* not 0: four maps share a texel: fewer pages, four times the draws */
    const char *vertex;         /* your own shaders for casters (skinning, alpha masks), written as */
    const char *fragment;       /* lib/envsh_cast.glsl says; both NULL = the library's */
} glbk_envsh_maps_desc;

typedef struct glbk_envsh_maps {        /* the shadow maps of a frame; read only; zeroed = none */
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
    uint32_t     map_side;              /* of the desc, with their defaults */
    uint32_t     guard;
    uint32_t     capacity;
    uint32_t     channels;              /* maps that share a texel: 1, or 4 with rgba */
    uint32_t     count;                 /* lights whose maps were rendered last; 0 after an error */
    uint32_t     across;                /* tiles of a page: columns, */
    uint32_t     down;                  /* and rows */
    uint32_t     pages;
    uint32_t     cells_side;            /* cells a side of a tile, on the finest level */
    uint32_t     levels;                /* levels of cells */
    uint32_t     first;                 /* while casters are drawn: the light of instance 0, */
    uint32_t     step;                  /* how much farther on that of the next instance is, */
    uint32_t     casts;                 /* and how often glbk_envsh_cast was called */
} glbk_envsh_maps;

GLBK_DEF glbk_result glbk_envsh_maps_create(glbk_context *ctx, const glbk_envsh_maps_desc *desc,
                                            glbk_envsh_maps *out);
/* Makes room for shadow maps, which glbk_envsh_maps_free takes back. The tiles lie as square as they can in
   pages of at most ctx->max_side (and 8192) texels a side.
   desc     must be given: its capacity has no default
   out      zeroed on errors
   Memory   on the GPU: 4 bytes for each of map_side^2 x capacity texels; with rgba another 4 for each texel
            of one page; for cells 0.17 for each texel (up to 0.7 if map_side / 8 is no power of two); and 128
            for each light
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL); GLBK_ERR_DESC (a field is out of range, or one of vertex
            and fragment is missing); GLBK_ERR_LIMIT (there would be more than ctx->max_layers or 1024 pages);
            those of programs, textures and targets */
GLBK_DEF void glbk_envsh_maps_free(glbk_context *ctx, glbk_envsh_maps *maps);
/* Frees what glbk_envsh_maps_create made, and zeroes the struct. NULL and zeroed maps are allowed. */

typedef glbk_result (*glbk_envsh_draw_fn)(void *user, glbk_context *ctx, glbk_envsh_maps *maps,
                                          uint32_t instances);
/* Draws everything that casts shadows. For each object it calls glbk_envsh_cast, binds its vertex array
   (attribute 0 is the position), and draws `instances` instances. Returns GLBK_OK; any other result ends the
   call that renders the maps and is what that call returns. The function is called once for each page, with
   rgba once for each of the four channels of a page, and on OpenGL ES that often for each column of tiles;
   with desc.check of the context twice as often, and it must draw the same each time. */

GLBK_DEF glbk_result glbk_envsh_cast(glbk_context *ctx, glbk_envsh_maps *maps, const float world[16]);
/* Sets the matrix of the next object that a glbk_envsh_draw_fn draws. Only such a function may call it.
   world    object to world, column by column; NULL = identity
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL, or the maps were not created), GLBK_ERR_LOST */

GLBK_DEF glbk_result glbk_envsh_maps_render(glbk_context *ctx, glbk_envsh_maps *maps, const envsh_view *views,
                                            uint32_t count, glbk_envsh_draw_fn draw_fn, void *user);
/* Draws the shadow maps of a frame, and what is known of their cells.
   views    those of envsh_get_views. Where they say that their tiles lie plays no part. envsh_maps_desc had
            the same map_side and guard as the desc of these maps
   count    at most the capacity; 0 = no light
   draw_fn  draws what casts shadows; user is given to it
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL, or there are too many views); GLBK_ERR_MISMATCH (the views
            are for tiles of another size or guard); what draw_fn returned. With desc.check of the context
            GLBK_ERR_ORDER: draw_fn did not call glbk_envsh_cast, or drew fewer instances of a caster than it
            was given. To find that out, the maps are drawn once more with the instances in the opposite
            order, and both results are read back and compared; a draw_fn that draws nothing at all is not
            noticed, since all casters may lie beyond the bounds */

GLBK_DEF glbk_result glbk_envsh_bind(glbk_context *ctx, glbk_envsh_maps *maps, const envsh_query *query,
                                     const glbk_offset *offset);
/* Binds textures and uniform blocks for a program of your own, which is in use (glbk_begin). The program has
   envsh_light among its library files, and among its defines ENVSH_FILTER, the number of the query's filter,
   and ENVSH_RGBA, 1 if the maps were made with rgba and else 0.
   query    NULL = all defaults; its add plays no part
   offset   the offset that the part envsh has in the program; NULL = none
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL, or the maps were not created); GLBK_ERR_DESC (a field of the
            query is out of range) */

/* ---- envsh: complete passes ----

   First call glbk_envsh_maps_create, glbk_gbuffer_create (gl_gbuffer.h) and glbk_envsh_renderer_create once.
   A frame:

       envsh_maps_begin(layout, &lights, bounds);              // envshadow.h: the matrices of the views
       glbk_gbuffer_begin(gl, &seen, world_to_clip, eye);      // or glbk_gbuffer_import, or _upload
       glbk_gbuffer_object(gl, &seen, &surface);               // for each object, and your draw
       glbk_envsh_illuminate(gl, &r, &seen, &maps, &frame);
       glbk_envsh_resolve(gl, &r, &seen, &pass, NULL);

   glbk_envsh_illuminate is glbk_envsh_maps_render and glbk_envsh_shade, one after the other, as often as it
   takes. If ctx->compute is set, light is summed up by compute shaders. */

typedef struct glbk_envsh_renderer {    /* the light of a picture; read only; zeroed = none */
    glbk_program shade[2 * ENVSH_FILTER_COUNT];     /* by 2 x filter + rgba, compiled at first use */
    glbk_program resolve;
    glbk_texture sums[2];               /* irradiance: one is read while the other is drawn */
    glbk_target  targets[2];
    glbk_buffer  object;                /* the uniform block of the resolve */
    uint32_t     width, height;         /* pixels */
    uint32_t     now;                   /* which of the sums holds the light */
    int          begun;                 /* not 0: the sum holds light */
    int          compute;               /* not 0: there is one sum, which is changed in place */
} glbk_envsh_renderer;

GLBK_DEF glbk_result glbk_envsh_renderer_create(glbk_context *ctx, uint32_t width, uint32_t height,
                                                glbk_envsh_renderer *out);
/* Makes a renderer for pictures of one size, which glbk_envsh_renderer_free takes back.
   width    and height: pixels, 1 to ctx->max_side
   out      zeroed on errors
   Memory   on the GPU: 32 bytes for each pixel, by compute 16
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL); those of programs, textures and targets */
GLBK_DEF void glbk_envsh_renderer_free(glbk_context *ctx, glbk_envsh_renderer *renderer);
/* Frees what glbk_envsh_renderer_create made, and zeroes the struct. NULL and a zeroed renderer are
   allowed. */

GLBK_DEF glbk_result glbk_envsh_shade(glbk_context *ctx, glbk_envsh_renderer *renderer,
                                      const glbk_gbuffer *gbuffer, glbk_envsh_maps *maps,
                                      const envsh_query *query, uint32_t lights_per_pass);
/* Computes the irradiance that each pixel gets from the lights whose maps glbk_envsh_maps_render drew last:
   the sum of visibility times cosine times the light's own irradiance. Takes the place of the light that the
   renderer has, or, with query->add, is added to it. The first use of a filter compiles a program.
   gbuffer          the points that are lit, of the renderer's size
   query            how the maps are filtered; NULL = all defaults
   lights_per_pass  how many lights one pass adds up; 0 = all, as in the paper. Give fewer if the driver stops
                    passes that take long
   Cost             grows with pixels, lights and the query's taps; taps are spared where all texels about
                    them are on one side of the point
   Errors           GLBK_ERR_ARGUMENT (a pointer is NULL, or something was not created); GLBK_ERR_DESC (a
                    field of the query is out of range); GLBK_ERR_MISMATCH (the G-buffer has another size);
                    those of glbk_program_compile at first use */

typedef struct glbk_envsh_frame {       /* what a frame is lit by, and what casts shadows in it */
    const envsh_view  *views;           /* of all lights: of an envsh_maps with no_depth and room for all */
    uint32_t           view_count;      /* 0 = no light */
    glbk_envsh_draw_fn draw_fn;         /* draws what casts shadows; required */
    void              *user;            /* given to draw_fn */
    const envsh_query *query;           /* NULL = all defaults; its add plays no part */
} glbk_envsh_frame;

GLBK_DEF glbk_result glbk_envsh_illuminate(glbk_context *ctx, glbk_envsh_renderer *renderer,
                                           const glbk_gbuffer *gbuffer, glbk_envsh_maps *maps,
                                           const glbk_envsh_frame *frame);
/* Computes the irradiance of each pixel from all lights of a frame: renders the maps of as many lights as the
   maps hold, adds their light, and goes on with the next ones. That is the paper's algorithm 2, or algorithm
   1 if the maps hold all lights. Takes the place of the light that the renderer has.
   Errors   GLBK_ERR_ARGUMENT (a required pointer is NULL); those of glbk_envsh_maps_render and
            glbk_envsh_shade */

GLBK_DEF glbk_result glbk_envsh_resolve(glbk_context *ctx, glbk_envsh_renderer *renderer,
                                        const glbk_gbuffer *gbuffer, const glbk_pass *pass,
                                        const glbk_picture *picture);
/* Draws irradiance x albedo / pi, which is linear radiance, to the pass's target. The albedo is the
   G-buffer's diffuse colour, of metal-rough surfaces times 1 - metallic.
   pass     where the picture is drawn and how it is blended; its viewport says where in the target
   picture  whether empty pixels and depths are drawn, see glbk_picture; NULL = every pixel, without depths
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL), GLBK_ERR_MISMATCH (the G-buffer has another size); those of
            glbk_begin */
GLBK_DEF glbk_result glbk_envsh_read(glbk_context *ctx, glbk_envsh_renderer *renderer, float *rgba);
/* Reads the irradiance, W/m^2, back to the CPU, and waits for the GPU meanwhile.
   rgba     gets 4 floats for each pixel, row 0 of the G-buffer first; the last of four is 0
   Errors   GLBK_ERR_ARGUMENT (a pointer is NULL, or the renderer was not created); GLBK_ERR_LOST */
