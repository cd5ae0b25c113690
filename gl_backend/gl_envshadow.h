/* gl_envshadow.h - v0.9.0 - environment-map shadows on OpenGL 3.3, ES 3.0 and WebGL 2 - MIT-0 OR Unlicense

   What it does

   The header draws the shadow maps of a sky's lights, all into one atlas, through a callback of yours.
   Shaders of your own light points with all of them by one call, envsh_light(). Or complete passes light a
   G-buffer, with all lights at once or with clusters of them one after the other.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, textures and targets, and whose
     conventions, errors and rules about GL's state hold here; gl_programs.h, which makes programs;
     and gl_gbuffer.h, for complete passes.
   - It chooses no lights. envlights.h does that, or you do. envshadow.h says where their maps lie and which
     matrices they are drawn with.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #define GL_ENVSHADOW_IMPLEMENTATION
       #include "gl_backend/gl_envshadow.h"
       #include <stdio.h>
       #include <string.h>

       // With GLFW: return glfwGetProcAddress(name);  with EGL: return eglGetProcAddress(name);
       static glbk_proc_fn get_proc(const char *name, void *user)
       {
           (void)name; (void)user;
           return NULL;                                     // no GL here: glbk_init says so below
       }

       int main(void)
       {
           static const char fragment[] =                   // your shader, which calls the library's function
               "out vec4 color;\n"
               "void main()\n"
               "{\n"
               "    vec3 place = vec3(gl_FragCoord.xy, 0.0), up = vec3(0.0, 1.0, 0.0);\n"
               "    color = vec4(envsh_light(place, up, up, 0u), 1.0);\n"
               "}\n";
           glbk_context gl;
           glbk_program program;
           glbk_desc desc;
           glbk_source source;
           glbk_result result;

           memset(&desc, 0, sizeof desc);
           desc.get_proc_fn = get_proc;                        // a context is current
           result = glbk_init(&gl, &desc);
           if (result != GLBK_OK) {
               printf("no GL: %s\n", glbk_result_text(result));
               return result != GLBK_ERR_FUNCTION;
           }
           memset(&source, 0, sizeof source);
           source.parts[0] = glbk_envsh_part();               // the GLSL of this header
           source.uses = "envsh_light";
           source.defines = "ENVSH_FILTER=3 ENVSH_RGBA=0";
           source.fragment = fragment;
           result = glbk_program_compile(&gl, &source, &program);
           printf("%s\n", glbk_result_text(result));
           glbk_program_free(&gl, &program);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   The whole frame, with a window: examples/08_envshadow_gl_minimal.c.

   Vectors

   A vector that is said to be unit may have a length of 0.97 to 1.03 and is used as it is; envshadow.h checks
   those of lights, gl_gbuffer.h those of pixels, and in shaders of your own nothing is checked.

   From the paper to the code

   The paper is that of envshadow.h: Knuth and Fuhrmann, "Self-Shadowing of Dynamic Scenes with Environment
   Maps using the GPU", WSCG 2005. A line has the function in GLSL or the call, its twin in envshadow.h, and
   the rows of docs/conformance.md that test both.

     3, algorithm 1, all lights at once  glbk_envsh_shade        envsh_shade             T23
     3, algorithm 2, clusters of lights  glbk_envsh_illuminate   envsh_illuminate        -
     3, Fig. 2, maps side by side        glbk_envsh_maps_render  envsh__lay_out_tiles    T24
     3, Fig. 4, smoothing                envsh_smooth            envsh__filter_smooth    -
     4, Fig. 5, maps in color channels   envsh_lit               envsh__is_lit           T24
     4, percentage closer filtering      envsh_taps              envsh__filter_taps      T24
     6, size of the light source         envsh_penumbra          envsh__filter_penumbra  -

   Lines without a row are compared with their twins by tests/envshadow/gl_twin_test.c.

   Configuration

     GL_ENVSHADOW_IMPLEMENTATION   compiles the code, in one source file; the implementations of
                                   gl_backend.h, gl_programs.h and gl_gbuffer.h may be compiled in another

   Layouts: docs/gpu-layouts.md.   The technique: docs/envshadow.md.   State: docs/gl-state.md.
   Licence: end of file. */
/* These includes stand outside the guard, since an implementation may be asked for when the file is included
   for the second time. envshadow.h lies above this folder. */
#include "gl_gbuffer.h"
#include "../envshadow.h"

#ifndef GL_ENVSHADOW_H
#define GL_ENVSHADOW_H

#if GLBK_VERSION != 900
#error "gl_envshadow.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_ENVSHADOW_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_ENVSHADOW_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/gl_envshadow/api_page_one.h ==== */

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

/* ==== src/gl_envshadow/api.h ==== */

/* ---- the steps of glbk_envsh_illuminate ---- */

GLBK_DEF glbk_result glbk_envsh_maps_render(glbk_context *ctx, glbk_envsh_maps *maps, const envsh_view *views,
                                            uint32_t count, glbk_envsh_draw_fn draw_fn, void *user);
/* Draws the shadow maps of a frame, and what is known of their cells.
   views    those of envsh_views, of an envsh_maps_desc with the same map_side and guard as the desc of
            these maps. Where the views say that their tiles lie plays no part
   count    at most the capacity; 0 = no light
   draw_fn  draws what casts shadows; user is given to it
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the maps were not created. GLBK_ERR_LIMIT: count is above
            the capacity. GLBK_ERR_MISMATCH: the views are for tiles of another size or guard. What draw_fn
            returned. With desc.check of the context GLBK_ERR_ORDER: draw_fn did not call glbk_envsh_cast, or
            drew fewer instances of a caster than it was given. To find that out, the maps are drawn once more
            with the instances in the opposite order, and both results are read back and compared. A draw_fn
            that draws nothing at all is not noticed, since all casters may lie beyond the bounds */

GLBK_DEF glbk_result glbk_envsh_shade(glbk_context *ctx, glbk_envsh_renderer *renderer,
                                      const glbk_gbuffer *gbuffer, glbk_envsh_maps *maps,
                                      const envsh_query *query, uint32_t lights_per_pass);
/* Computes the irradiance that each pixel gets from the lights whose maps glbk_envsh_maps_render drew last:
   the sum of visibility times cosine times the light's own irradiance. The sum replaces the light that the
   renderer has or, with query->add, is added to it. The first use of a filter compiles a program.
   gbuffer          the points that are lit, of the renderer's size
   query            how the maps are filtered; NULL = all defaults
   lights_per_pass  how many lights one pass adds up; 0 = all, as in the paper. Give fewer if the driver stops
                    passes that take long
   Cost             grows with pixels, lights and the query's taps; taps are spared if all texels about them
                    are on one side of the point
   Errors           GLBK_ERR_ARGUMENT: a pointer is NULL, or an object was not created. GLBK_ERR_DESC: a field
                    of the query is out of range. GLBK_ERR_MISMATCH: the G-buffer has another size. Those of
                    glbk_program_compile at first use */

GLBK_DEF glbk_result glbk_envsh_read(glbk_context *ctx, glbk_envsh_renderer *renderer, float *rgba);
/* Reads the irradiance, W/m^2, back to the CPU, and waits for the GPU meanwhile.
   rgba     gets 4 floats for each pixel, row 0 of the G-buffer first; the last of four is 0
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the renderer was not created. GLBK_ERR_LOST */

GLBK_DEF void glbk_envsh_maps_free(glbk_context *ctx, glbk_envsh_maps *maps);
/* Frees what glbk_envsh_maps_create made, and zeroes the struct. NULL and zeroed maps are allowed. */

GLBK_DEF glbk_result glbk_envsh_renderer_resize(glbk_context *ctx, glbk_envsh_renderer *renderer,
                                                uint32_t width, uint32_t height);
/* Gives the renderer another size, without what it had drawn. Its programs stay, whereas a new renderer would
   compile them anew; so call it when a window has changed its size, with glbk_gbuffer_resize. Its textures
   are new ones.
   Errors   GLBK_ERR_ARGUMENT: the renderer is NULL or was not created. GLBK_ERR_DESC, GLBK_ERR_LIMIT: as for
            glbk_envsh_renderer_create. After these it is as it was, after those of textures and targets
            it is freed and zeroed */

GLBK_DEF void glbk_envsh_renderer_free(glbk_context *ctx, glbk_envsh_renderer *renderer);
/* Frees what glbk_envsh_renderer_create made, and zeroes the struct. NULL and a zeroed renderer are
   allowed. */

/* ---- shaders of your own ----

   After glbk_envsh_bind they call these functions of lib/envsh_light.glsl:

       vec3 envsh_light(vec3 p, vec3 n, vec3 flat_n, uint index);  // irradiance by all lights, W/m^2
       float envsh_visible(envsh_query q, uint light, vec3 p, vec3 n, uint index);     // 0 hidden .. 1 seen
       envsh_query envsh_bound_query();                            // the query that was bound
       vec3 envsh_direction(uint light);                           // unit, to the light
       vec3 envsh_power(uint light);                               // its irradiance where it is faced, W/m^2

   p is a point in world space. Normals are unit and on the side that is seen: n of envsh_light is the shading
   normal, flat_n and n of envsh_visible are the surface's own. index turns the pattern of taps: give each
   pixel another one. glbk_envsh_scene.light_count is the number of lights. docs/gpu-layouts.md describes all
   textures and blocks. */

GLBK_DEF const glbk_part *glbk_envsh_part(void);
/* Returns the GLSL of this header, for programs of your own that use its library files: see
   glbk_source.parts. */

GLBK_DEF glbk_result glbk_envsh_bind(glbk_context *ctx, glbk_envsh_maps *maps, const envsh_query *query,
                                     const glbk_offset *offset);
/* Binds textures and uniform blocks for a program of your own, which is in use (glbk_begin). The program has
   envsh_light among its library files, and among its defines ENVSH_FILTER, the number of the query's filter,
   and ENVSH_RGBA, 1 if the maps were made with rgba and else 0.
   query    NULL = all defaults; its add plays no part
   offset   the offset that the part envsh has in the program; NULL = none
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the maps were not created. GLBK_ERR_DESC: a field of the
            query is out of range */

/* ==== src/gl_envshadow/bindings.h ==== */

/* ---- what the GLSL of this header declares; see "bindings" in gl_programs.h ---- */

#define GLBK_ENVSH_TEXTURES(X)                                                                      \
    X(sampler2DArray, glbk_envsh_depth, 0)      /* the atlas, of depths */                          \
    X(usampler2DArray, glbk_envsh_depth4, 1)    /* with rgba: the atlas, of four maps' bits */      \
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
    X(float, clip_per_texel_x, 1)   /* 2 / texels of a page along x */                              \
    X(float, clip_per_texel_y, 1)   /* 2 / texels of a page along y */

#define GLBK_ENVSH_QUERY_MEMBERS(X)                                                                 \
    X(float, radius, 1)             /* of envsh_query with its default, like the next four */       \
    X(float, bias, 1)                                                                               \
    X(float, extent_scale, 1)                                                                       \
    X(uint, taps, 1)                                                                                \
    X(uint, seed, 1)                                                                                \
    X(uint, first_light, 1)         /* the first light of a pass */                                 \
    X(uint, end_light, 1)           /* the light after its last */                                  \
    X(uint, adds, 1)                /* not 0: their light is added to the sum; 0: it begins here */ \
    X(vec4, disc, 32)               /* the taps on the unit disc, two in each */

#define GLBK_ENVSH_OBJECT_MEMBERS(X)                                                                \
    X(mat4, transform, 1)           /* of a caster: object to world */                              \
    X(uint, first_light, 1)         /* the light of instance 0 */                                   \
    X(uint, light_step, 1)          /* from the light of an instance to that of the next */         \
    X(uint, level, 1)               /* the level of cells that are made */                          \
    X(uint, layer, 1)               /* the layer of cells that are made */                          \
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

/* ==== src/gl_envshadow/begin.h ==== */

/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_ENVSHADOW_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_ENVSHADOW_IMPLEMENTATION) && !defined(GL_ENVSHADOW_IMPLEMENTED)
#define GL_ENVSHADOW_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== src/shared/mem.h ==== */

/* unit mem: checked sizes, and the caller's allocator with malloc and free as its default */

typedef struct glbk_envsh__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} glbk_envsh__allocator;

static inline void *glbk_envsh__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void glbk_envsh__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
static inline int glbk_envsh__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

static inline glbk_envsh__allocator glbk_envsh__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    glbk_envsh__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : glbk_envsh__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : glbk_envsh__default_free;
    a.user = user;
    return a;
}

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *glbk_envsh__alloc(const glbk_envsh__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *glbk_envsh__alloc_array(const glbk_envsh__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return glbk_envsh__mul_size(count, item_size, &size) ? glbk_envsh__alloc(a, size) : NULL;
}

static inline void glbk_envsh__free(const glbk_envsh__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/gl_memory.h ==== */

/* unit gl_memory, needs mem: the allocator of a glbk_context (gl_backend.h) */

static inline glbk_envsh__allocator glbk_envsh__memory(const glbk_context *ctx)
{
    const glbk_allocator *a = &ctx->system.allocator;
    return glbk_envsh__allocator_make(a->alloc_fn, a->free_fn, a->user);
}

/* ==== GLSL of src/gl_envshadow ==== */


static const struct { char facts[58];
    char s0[1094]; char end; } glbk__glsl_lib_envsh_access_glsl GLBK__TIGHT = {
    "lib/envsh_access.glsl\0" "table envsh_bindings envsh_scene" "\0" "" "\0"
    "" "\0" "",
    "\n\n#ifndef ENVSH_RGBA\n"
    "#error \"ENVSH_RGBA: 1 where four maps share a texel (glbk_envsh_maps_desc.rgba), else 0\"\n"
    "#endif\n"
    "#ifndef ENVSH_TEXEL\n"
    "#define ENVSH_TEXEL(i) texelFetch(glbk_envsh_views, glbk_table_at(i), 0)\n"
    "#endif\n"
    "#define ENVSH_CHANNELS (ENVSH_RGBA == 1 ? 4u : 1u)\n"
    "#define ENVSH_STORED(view, at) envsh_stored(view.light, view.place, at)\n"
    "#define ENVSH_CELL(view, at, level) envsh_cell(view.light, view.place, at, level)\n"
    "\n\nivec2 envsh_slot(uint place){return ivec2(uvec2(place&2047u,(place>>11)&2047u));}\n"
    "\n\nfloat envsh_stored(uint light,uint place,ivec2 at)\n"
    "{\n"
    "ivec3 texel=ivec3(envsh_slot(place)*int(glbk_envsh_scene.map_side)+at,int(place>>22));\n"
    "#if ENVSH_RGBA\n"
    "return uintBitsToFloat(texelFetch(glbk_envsh_depth4,texel,0)[light&3u]);\n"
    "#else\n"
    "return texelFetch(glbk_envsh_depth,texel,0).x;\n"
    "#endif\n"
    "}\n"
    "\n\nvec2 envsh_cell(uint light,uint place,ivec2 at,int level)\n"
    "{\n"
    "int layer=int((place>>22)*ENVSH_CHANNELS+(light&(ENVSH_CHANNELS-1u)));\n"
    "ivec2 corner=envsh_slot(place)*(int(glbk_envsh_scene.cells_side)>>level);\n"
    "return uintBitsToFloat(texelFetch(glbk_envsh_cells,ivec3(corner+at,layer),level).xy);\n"
    "}\n", 0
};

static const struct { char facts[28];
    char s0[261]; char end; } glbk__glsl_lib_envsh_bindings_glsl GLBK__TIGHT = {
    "lib/envsh_bindings.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\nuniform sampler2DArray glbk_envsh_depth;\n"
    "uniform usampler2DArray glbk_envsh_depth4,glbk_envsh_cells,glbk_envsh_views;\n"
    "uniform glbk_color_sampler glbk_envsh_sum;\n"
    "#if __VERSION__ >= 430\n"
    "layout(rgba32f,binding=0)restrict uniform image2D glbk_envsh_total;\n"
    "#endif\n", 0
};

static const struct { char facts[69];
    char s0[1995]; char end; } glbk__glsl_lib_envsh_cast_glsl GLBK__TIGHT = {
    "lib/envsh_cast.glsl\0" "table envsh_bindings envsh_object envsh_scene" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n#ifndef ENVSH_RGBA\n"
    "#error \"ENVSH_RGBA: 1 where four maps share a texel (glbk_envsh_maps_desc.rgba), else 0\"\n"
    "#endif\n"
    "\nstruct envsh_vertex{\n"
    "vec4 position;\n"
    "vec4 inside;\n"
    "float depth;\n"
    "};\n"
    "\n\n\n\n\nenvsh_vertex envsh_cast(int instance,vec3 world)\n"
    "{\n"
    "uint at=8u*(glbk_envsh_object.first_light+glbk_envsh_object.light_step*uint(instance));\n"
    "vec4 p=vec4(world,1.);\n"
    "uint side=glbk_envsh_scene.map_side,guard=glbk_envsh_scene.guard;\n"
    "vec2 texel=vec2(dot(uintBitsToFloat(texelFetch(glbk_envsh_views,glbk_table_at(at),0)),p),\n"
    "dot(uintBitsToFloat(texelFetch(glbk_envsh_views,glbk_table_at(at+1u),0)),p));\n"
    "uint place=texelFetch(glbk_envsh_views,glbk_table_at(at+6u),0).w;\n"
    "vec2 corner=vec2(uvec2(place&2047u,(place>>11)&2047u)*side);\n"
    "envsh_vertex v;\n"
    "v.depth=dot(uintBitsToFloat(texelFetch(glbk_envsh_views,glbk_table_at(at+2u),0)),p);\n"
    "v.inside=vec4(texel-float(guard),float(side-guard)-texel);\n"
    "#ifdef GL_ES\n"
    "vec2 inner=v.inside.xy*glbk_envsh_scene.clip_per_inside-1.;\n"
    "float y=(corner.y+texel.y)*glbk_envsh_scene.clip_per_texel_y-1.;\n"
    "v.position=vec4(inner.x,y,inner.y,1.);\n"
    "#else\n"
    "vec2 clip_per_texel=vec2(glbk_envsh_scene.clip_per_texel_x,glbk_envsh_scene.clip_per_texel_y);\n"
    "v.position=vec4((corner+texel)*clip_per_texel-1.,2.*v.depth-1.,1.);\n"
    "#endif\n"
    "return v;\n"
    "}\n"
    "\n#ifdef GL_ES\n"
    "#define ENVSH_CLIP(d)\n"
    "#define ENVSH_WRITE_DEPTH(depth) gl_FragDepth = clamp(depth, 0.0, 1.0);\n"
    "#else\n"
    "#define ENVSH_CLIP_PAIR(i, d) gl_ClipDistance[i] = d.x; gl_ClipDistance[i + 1] = d.y;\n"
    "#define ENVSH_CLIP(d) ENVSH_CLIP_PAIR(0, d.xy) ENVSH_CLIP_PAIR(2, d.zw)\n"
    "#define ENVSH_WRITE_DEPTH(depth)\n"
    "#endif\n"
    "#define ENVSH_SET(v) gl_Position = v.position; envsh_depth = v.depth; ENVSH_CLIP(v.inside)\n"
    "#define ENVSH_CAST(world) { envsh_vertex envsh_v = envsh_cast(gl_InstanceID, world); ENVSH_SET(envsh_v) }\n"
    "\n#if ENVSH_RGBA\n"
    "#define ENVSH_BITS(depth) uvec4(floatBitsToUint(clamp(depth, 0.0, 1.0)))\n"
    "#define ENVSH_STORE(depth) { envsh_bits = ENVSH_BITS(depth); ENVSH_WRITE_DEPTH(depth) }\n"
    "#else\n"
    "#define ENVSH_STORE(depth) { ENVSH_WRITE_DEPTH(depth) }\n"
    "#endif\n", 0
};

static const struct { char facts[45];
    char s0[299]; char end; } glbk__glsl_lib_envsh_chunk_glsl GLBK__TIGHT = {
    "lib/envsh_chunk.glsl\0" "table envsh_bindings" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n#define ENVSH_TEXEL(i) envsh_chunk[((i) & 504u) | (((i) ^ ((i) >> 3)) & 7u)]\n"
    "shared uvec4 envsh_chunk[512];\n"
    "\n\nvoid envsh_load_chunk(uint from,uint to)\n"
    "{\n"
    "for(uint i=8u*from+gl_LocalInvocationIndex;i<8u*min(from+64u,to);i+=64u)\n"
    "ENVSH_TEXEL(i)=texelFetch(glbk_envsh_views,glbk_table_at(i),0);\n"
    "}\n", 0
};

static const struct { char facts[50];
    char s0[151]; char end; } glbk__glsl_lib_envsh_disc_glsl GLBK__TIGHT = {
    "lib/envsh_disc.glsl\0" "envsh_bindings envsh_query" "\0" "" "\0"
    "" "\0" "",
    "\n\n#define ENVSH_DISC_PAIR(i) glbk_envsh_query.disc[(i) >> 1]\n"
    "#define ENVSH_DISC(i) (((i) & 1u) != 0u ? ENVSH_DISC_PAIR(i).zw : ENVSH_DISC_PAIR(i).xy)\n", 0
};

static const struct { char facts[38];
    char s0[1563]; char end; } glbk__glsl_lib_envsh_group_glsl GLBK__TIGHT = {
    "lib/envsh_group.glsl\0" "envsh_visible" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nstruct envsh_group{\n"
    "vec3 low,high;\n"
    "vec3 n_low,n_high;\n"
    "vec3 flat_low,flat_high;\n"
    "};\n"
    "\n\nbool envsh_all_under(vec3 low,vec3 high,vec3 d){return dot(max(low*d,high*d),vec3(1.))<-1e-5;}\n"
    "\n\nvec2 envsh_group_reach(envsh_query q,envsh_view v,float z)\n"
    "{\n"
    "#if ENVSH_FILTER == 1\n"
    "return vec2(.01);\n"
    "#elif ENVSH_FILTER == 2\n"
    "return vec2(q.radius+1.01);\n"
    "#elif ENVSH_FILTER == 3\n"
    "return vec2(q.radius+.01);\n"
    "#else\n"
    "vec2 a,b;\n"
    "envsh_kernel(q,v,z,a,b);\n"
    "return abs(a)+abs(b)+.71;\n"
    "#endif\n"
    "}\n"
    "\n\n\n\nint envsh_group_visible(envsh_query q,envsh_group g,uint light)\n"
    "{\n"
    "vec3 d=envsh_direction(light),center=.5*(g.low+g.high),extent=.5*(g.high-g.low);\n"
    "if(envsh_all_under(g.n_low,g.n_high,d)||envsh_all_under(g.flat_low,g.flat_high,d))return 0;\n"
    "envsh_view v=envsh_read_view(light);\n"
    "extent+=1.01*q.bias*max(v.texel.x,v.texel.y);\n"
    "if(!all(lessThan(extent,vec3(1e15))))return-1;\n"
    "vec4 middle=vec4(center,1.),wide=vec4(extent,.0)+1e-6*vec4(abs(center)+extent,1.);\n"
    "vec2 at=vec2(dot(v.row_x,middle),dot(v.row_y,middle));\n"
    "vec2 across=vec2(dot(abs(v.row_x),wide),dot(abs(v.row_y),wide));\n"
    "float z=dot(v.row_z,middle),deep=dot(abs(v.row_z),wide);\n"
    "vec3 n=.5*(g.flat_low+g.flat_high),n_extent=.5*(g.flat_high-g.flat_low);\n"
    "vec2 flat_n=abs(vec2(dot(n,v.right),dot(n,v.up)));\n"
    "flat_n+=vec2(dot(n_extent,abs(v.right)),dot(n_extent,abs(v.up)));\n"
    "float cosine=max(dot(n,d)-dot(n_extent,abs(d)),.1);\n"
    "vec2 reach=envsh_group_reach(q,v,z+deep);\n"
    "float slope=1.001*dot(flat_n*v.texel,reach+1.)/(cosine*v.depth_range);\n"
    "return envsh_decide_box(q,v,at,across+reach,z-deep-min(slope,1.001*envsh_plane_limit(q,v)),\n"
    "z+deep+slope);\n"
    "}\n", 0
};

static const struct { char facts[62];
    char s0[478]; char end; } glbk__glsl_lib_envsh_light_glsl GLBK__TIGHT = {
    "lib/envsh_light.glsl\0" "envsh_access envsh_disc envsh_visible" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\nenvsh_query envsh_bound_query()\n"
    "{\n"
    "envsh_query q;\n"
    "q.radius=glbk_envsh_query.radius;\n"
    "q.bias=glbk_envsh_query.bias;\n"
    "q.extent_scale=glbk_envsh_query.extent_scale;\n"
    "q.taps=glbk_envsh_query.taps;\n"
    "q.seed=glbk_envsh_query.seed;\n"
    "q.side=int(glbk_envsh_scene.map_side);\n"
    "q.levels=int(glbk_envsh_scene.level_count);\n"
    "return q;\n"
    "}\n"
    "\n\n\n\nvec3 envsh_light(vec3 p,vec3 n,vec3 flat_n,uint index)\n"
    "{\n"
    "return envsh_irradiance(envsh_bound_query(),0u,glbk_envsh_scene.light_count,p,n,flat_n,index);\n"
    "}\n", 0
};

static const struct { char facts[43];
    char s0[154]; char end; } glbk__glsl_lib_envsh_object_glsl GLBK__TIGHT = {
    "lib/envsh_object.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_envsh_object",
    "\nlayout(std140)uniform glbk_envsh_object_block{\n"
    "mat4 transform;\n"
    "uint first_light,light_step,level,layer,lit,unused0,unused1,unused2;\n"
    "}glbk_envsh_object;\n", 0
};

static const struct { char facts[41];
    char s0[157]; char end; } glbk__glsl_lib_envsh_query_glsl GLBK__TIGHT = {
    "lib/envsh_query.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_envsh_query",
    "\nlayout(std140)uniform glbk_envsh_query_block{\n"
    "float radius,bias,extent_scale;\n"
    "uint taps,seed,first_light,end_light,adds;\n"
    "vec4 disc[32];\n"
    "}glbk_envsh_query;\n", 0
};

static const struct { char facts[41];
    char s0[180]; char end; } glbk__glsl_lib_envsh_scene_glsl GLBK__TIGHT = {
    "lib/envsh_scene.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_envsh_scene",
    "\nlayout(std140)uniform glbk_envsh_scene_block{\n"
    "uint map_side,guard,cells_side,level_count,light_count;\n"
    "float clip_per_inside,clip_per_texel_x,clip_per_texel_y;\n"
    "}glbk_envsh_scene;\n", 0
};

static const struct { char facts[27];
    char s0[3963]; char s1[2895]; char end; } glbk__glsl_lib_envsh_visible_glsl GLBK__TIGHT = {
    "lib/envsh_visible.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n\n\n#if !(defined ENVSH_FILTER && defined ENVSH_TEXEL && defined ENVSH_STORED)\n"
    "#error \"envsh_visible: define ENVSH_FILTER, ENVSH_TEXEL and ENVSH_STORED\"\n"
    "#endif\n"
    "#if !(defined ENVSH_CELL && defined ENVSH_DISC)\n"
    "#error \"envsh_visible: define ENVSH_CELL and ENVSH_DISC\"\n"
    "#endif\n"
    "#if ENVSH_FILTER == 0\n"
    "#undef ENVSH_FILTER\n"
    "#define ENVSH_FILTER 4\n"
    "#endif\n"
    "\nstruct envsh_query{\n"
    "float radius,bias,extent_scale;\n"
    "uint taps,seed;\n"
    "int side;\n"
    "int levels;\n"
    "};\n"
    "\nstruct envsh_view{\n"
    "vec4 row_x,row_y;\n"
    "vec4 row_z;\n"
    "vec3 right,up;\n"
    "vec2 texel;\n"
    "float depth_range;\n"
    "vec4 spread;\n"
    "uint light;\n"
    "uint place;\n"
    "};\n"
    "\nstruct envsh_receiver{\n"
    "vec2 at;\n"
    "vec2 slope;\n"
    "float z;\n"
    "float limit;\n"
    "};\n"
    "\n\nvec4 envsh_texel(uint light,uint i){return uintBitsToFloat(ENVSH_TEXEL(8u*light+i));}\n"
    "\n\nvec3 envsh_direction(uint light){return envsh_texel(light,5u).xyz;}\n"
    "\n\nvec3 envsh_power(uint light){return envsh_texel(light,6u).xyz;}\n"
    "\n\nenvsh_view envsh_read_view(uint light)\n"
    "{\n"
    "envsh_view v;\n"
    "vec4 right=envsh_texel(light,3u),up=envsh_texel(light,4u);\n"
    "v.row_x=envsh_texel(light,0u);\n"
    "v.row_y=envsh_texel(light,1u);\n"
    "v.row_z=envsh_texel(light,2u);\n"
    "v.right=right.xyz;\n"
    "v.up=up.xyz;\n"
    "v.texel=vec2(right.w,up.w);\n"
    "v.depth_range=envsh_texel(light,5u).w;\n"
    "v.place=ENVSH_TEXEL(8u*light+6u).w;\n"
    "v.spread=envsh_texel(light,7u);\n"
    "v.light=light;\n"
    "return v;\n"
    "}\n"
    "\n\nuint envsh_hash32(uint x)\n"
    "{\n"
    "uint state=x*747796405u+2891336453u;\n"
    "uint word=((state>>((state>>28)+4u))^state)*277803737u;\n"
    "return(word>>22)^word;\n"
    "}\n"
    "\n\nuint envsh_hash_combine(uint a,uint b){return envsh_hash32(a+0x9e3779b9u*envsh_hash32(b));}\n"
    "\n\n\nvec2 envsh_turn(float x)\n"
    "{\n"
    "int k=int(x*.636619772+.5);\n"
    "float r=((x-float(k)*1.5703125)-float(k)*4.837512969970703125e-4)-\n"
    "float(k)*7.5497899548918822e-8;\n"
    "float z=r*r,s=r+r*z*(-.1666665494+z*(.008332178146+z*-.0001951729898));\n"
    "float c=(1.-.5*z)+z*z*(.04166664687+z*(-.001388736752+z*2.443845159e-5));\n"
    "vec2 cs=(k&1)!=0?vec2(s,c):vec2(c,s);\n"
    "return vec2(((k+1)&2)!=0?-cs.x:cs.x,(k&2)!=0?-cs.y:cs.y);\n"
    "}\n"
    "\n\nivec2 envsh_place(vec2 at){return ivec2(floor(clamp(at,vec2(-64.),vec2(8192.))));}\n"
    "\n\nbool envsh_outside(envsh_query q,ivec2 at)\n"
    "{\n"
    "return any(lessThan(at,ivec2(0)))||any(greaterThanEqual(at,ivec2(q.side)));\n"
    "}\n"
    "\n\n\nbool envsh_lit(envsh_query q,envsh_view v,envsh_receiver r,ivec2 at,out float stored)\n"
    "{\n"
    "stored=1.;\n"
    "if(envsh_outside(q,at))return true;\n"
    "stored=ENVSH_STORED(v,at);\n"
    "float z=r.z+max(dot(r.slope,vec2(at)+.5-r.at),-r.limit);\n"
    "return stored>=1.||z<=stored;\n"
    "}\n"
    "\n\n\nint envsh_decide_box(envsh_query q,envsh_view v,vec2 at,vec2 reach,float nearest,float farthest)\n"
    "{\n"
    "ivec2 low=envsh_place(at-reach),high=envsh_place(at+reach),last=ivec2(q.side-1);\n"
    "if(any(lessThan(high,ivec2(0)))||any(greaterThan(low,last)))return 1;\n"
    "bool outside=envsh_outside(q,low)||envsh_outside(q,high);\n"
    "low=max(low,ivec2(0));\n"
    "high=min(high,last);\n"
    "int wide=max(high.x-low.x,high.y-low.y),level=0;\n"
    "while(level+1<q.levels&&(8<<level)<wide)level++;\n"
    "low>>=3+level;\n"
    "high>>=3+level;\n"
    "vec2 a=ENVSH_CELL(v,low,level),b=ENVSH_CELL(v,ivec2(high.x,low.y),level);\n"
    "vec2 c=ENVSH_CELL(v,ivec2(low.x,high.y),level),d=ENVSH_CELL(v,high,level);\n"
    "float least=min(min(a.x,b.x),min(c.x,d.x)),most=max(max(a.y,b.y),max(c.y,d.y));\n"
    "if(least>=1.||farthest<=least)return 1;\n"
    "return!outside&&most<1.&&nearest>most?0:-1;\n"
    "}\n"
    "\n\nint envsh_decide(envsh_query q,envsh_view v,envsh_receiver r,vec2 reach)\n"
    "{\n"
    "float slope=dot(abs(r.slope),reach+1.);\n"
    "return envsh_decide_box(q,v,r.at,reach,r.z-min(slope,r.limit),r.z+slope);\n"
    "}\n"
    "\n\n\nfloat envsh_smooth(envsh_query q,envsh_view v,envsh_receiver r)\n"
    "{\n"
    "int reach=int(q.radius)+1;\n"
    "ivec2 center=envsh_place(r.at);\n"
    "float sum=.0,weights=.0,stored;\n"
    "for(int y=-reach;y<=reach;y++)\n"
    "for(int x=-reach;x<=reach;x++){\n"
    "ivec2 at=center+ivec2(x,y);\n"
    "vec2 w=q.radius+1.-abs(vec2(at)+.5-r.at);\n"
    "if(!(w.x>.0)||!(w.y>.0))continue;\n"
    "weights+=w.x*w.y;\n"
    "if(envsh_lit(q,v,r,at,stored))sum+=w.x*w.y;\n"
    "}\n"
    "return weights>.0?sum/weights:1.;\n"
    "}\n"
    "\n\nivec2 envsh_tap(envsh_receiver r,uint i,vec2 a,vec2 b,vec2 cs)\n"
    "{\n"
    "vec2 d=ENVSH_DISC(i);\n"
    "return envsh_place(r.at+(d.x*cs.x-d.y*cs.y)*a+(d.x*cs.y+d.y*cs.x)*b);\n"
    "}\n",
    "\n\nfloat envsh_taps(envsh_query q,envsh_view v,envsh_receiver r,vec2 a,vec2 b,vec2 cs)\n"
    "{\n"
    "float lit=.0,stored;\n"
    "for(uint i=0u;i<q.taps;i++)\n"
    "lit+=envsh_lit(q,v,r,envsh_tap(r,i,a,b,cs),stored)?1.:.0;\n"
    "return lit/float(q.taps);\n"
    "}\n"
    "\n\n\nvoid envsh_limit(inout vec2 a,inout vec2 b,float most)\n"
    "{\n"
    "float la=length(a),lb=length(b),least=min(.7,most),f;\n"
    "f=la>most?most/la:1.;\n"
    "a*=f;\n"
    "la*=f;\n"
    "f=lb>most?most/lb:1.;\n"
    "b*=f;\n"
    "lb*=f;\n"
    "if(la<least){\n"
    "a=vec2(least,.0);\n"
    "b=vec2(.0,least);\n"
    "}else if(lb<least){\n"
    "b=vec2(-a.y,a.x)*(least/la);\n"
    "}\n"
    "}\n"
    "\n\n\nvoid envsh_kernel(envsh_query q,envsh_view v,float away,out vec2 a,out vec2 b)\n"
    "{\n"
    "away=min(max(away,.0)*q.extent_scale,1e9);\n"
    "a=clamp(v.spread.xy*away,-1e15,1e15);\n"
    "b=clamp(v.spread.zw*away,-1e15,1e15);\n"
    "envsh_limit(a,b,q.radius);\n"
    "}\n"
    "\n\n\nfloat envsh_penumbra(envsh_query q,envsh_view v,envsh_receiver r,vec2 cs)\n"
    "{\n"
    "float occluders=.0,found=.0,stored;\n"
    "vec2 a,b;\n"
    "envsh_kernel(q,v,r.z,a,b);\n"
    "int known=envsh_decide(q,v,r,abs(a)+abs(b));\n"
    "if(known>=0)return float(known);\n"
    "for(uint i=0u;i<q.taps;i++)\n"
    "if(!envsh_lit(q,v,r,envsh_tap(r,i,a,b,cs),stored)){\n"
    "occluders+=stored;\n"
    "found+=1.;\n"
    "}\n"
    "if(found==.0)return 1.;\n"
    "envsh_kernel(q,v,r.z-occluders/found,a,b);\n"
    "return envsh_taps(q,v,r,a,b,cs);\n"
    "}\n"
    "\n\nfloat envsh_plane_limit(envsh_query q,envsh_view v)\n"
    "{\n"
    "float texels=4.;\n"
    "if(ENVSH_FILTER==1)texels=3.;\n"
    "if(ENVSH_FILTER==2)texels=q.radius+4.;\n"
    "if(ENVSH_FILTER==3)texels=q.radius+3.;\n"
    "return texels*max(v.texel.x,v.texel.y)/v.depth_range;\n"
    "}\n"
    "\n\n\nenvsh_receiver envsh_receive(envsh_query q,envsh_view v,vec3 p,vec3 n,float cosine)\n"
    "{\n"
    "envsh_receiver r;\n"
    "vec2 flat_n=vec2(dot(n,v.right),dot(n,v.up));\n"
    "float texel=max(v.texel.x,v.texel.y);\n"
    "p+=n*(q.bias*texel*(.25+.75*length(flat_n)));\n"
    "r.at=vec2(dot(v.row_x,vec4(p,1.)),dot(v.row_y,vec4(p,1.)));\n"
    "r.z=dot(v.row_z,vec4(p,1.));\n"
    "r.slope=flat_n*v.texel/(max(cosine,.1)*v.depth_range);\n"
    "r.limit=envsh_plane_limit(q,v);\n"
    "return r;\n"
    "}\n"
    "\n\n\nfloat envsh_visible(envsh_query q,uint light,vec3 p,vec3 n,uint index)\n"
    "{\n"
    "float cosine=dot(n,envsh_direction(light)),stored;\n"
    "if(!(cosine>.0))return .0;\n"
    "envsh_view v=envsh_read_view(light);\n"
    "envsh_receiver r=envsh_receive(q,v,p,n,cosine);\n"
    "#if ENVSH_FILTER == 1\n"
    "return envsh_lit(q,v,r,envsh_place(r.at),stored)?1.:.0;\n"
    "#elif ENVSH_FILTER == 2\n"
    "int known=envsh_decide(q,v,r,vec2(q.radius+1.));\n"
    "return known>=0?float(known):envsh_smooth(q,v,r);\n"
    "#else\n"
    "vec2 cs=envsh_turn(6.28318531*(float(envsh_hash_combine(q.seed,index)>>8)*(1./16777216.)));\n"
    "#if ENVSH_FILTER == 3\n"
    "int known=envsh_decide(q,v,r,vec2(q.radius));\n"
    "return known>=0?float(known):envsh_taps(q,v,r,vec2(q.radius,.0),vec2(.0,q.radius),cs);\n"
    "#else\n"
    "return envsh_penumbra(q,v,r,cs);\n"
    "#endif\n"
    "#endif\n"
    "}\n"
    "\n\n\nvec3 envsh_irradiance(envsh_query q,uint from,uint to,vec3 p,vec3 n,vec3 flat_n,uint index)\n"
    "{\n"
    "vec3 sum=vec3(.0);\n"
    "for(uint light=from;light<to;light++){\n"
    "float cosine=dot(n,envsh_direction(light));\n"
    "if(cosine>.0)sum+=envsh_visible(q,light,p,flat_n,index)*cosine*envsh_power(light);\n"
    "}\n"
    "return sum;\n"
    "}\n", 0
};

static const struct { char facts[113];
    char s0[158]; char end; } glbk__glsl_prog_envsh_cast_frag GLBK__TIGHT = {
    "prog/envsh_cast.frag\0" "envsh_cast mesh_fragment" "\0" "envsh_cast.vert" "\0"
    "ENVSH_RGBA=0 GLBK_PLACE | ENVSH_RGBA=1 GLBK_PLACE" "\0" "",
    "\n\n\n\nin float envsh_depth;\n"
    "#if ENVSH_RGBA\n"
    "layout(location=0)out uvec4 envsh_bits;\n"
    "#endif\n"
    "\nvoid main()\n"
    "{\n"
    "if(glbk_is_hole())discard;\n"
    "ENVSH_STORE(envsh_depth)\n"
    "}\n", 0
};

static const struct { char facts[96];
    char s0[119]; char end; } glbk__glsl_prog_envsh_cast_vert GLBK__TIGHT = {
    "prog/envsh_cast.vert\0" "envsh_cast mesh_vertex" "\0" "" "\0"
    "ENVSH_RGBA=0 GLBK_PLACE | ENVSH_RGBA=1 GLBK_PLACE" "\0" "",
    "\n\n\nout float envsh_depth;\n"
    "\nvoid main()\n"
    "{\n"
    "ENVSH_CAST((glbk_envsh_object.transform*vec4(glbk_vertex_place(),1.)).xyz)\n"
    "}\n", 0
};

static const struct { char facts[78];
    char s0[808]; char end; } glbk__glsl_prog_envsh_cells_frag GLBK__TIGHT = {
    "prog/envsh_cells.frag\0" "envsh_access envsh_object" "\0" "" "\0"
    "ENVSH_RGBA=0 | ENVSH_RGBA=1" "\0" "",
    "\n\n\n\n\nlayout(location=0)out uvec4 result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy);\n"
    "uint layer=glbk_envsh_object.layer;\n"
    "vec2 bounds=vec2(1.,.0);\n"
    "if(glbk_envsh_object.level==0u){\n"
    "int cells=int(glbk_envsh_scene.cells_side),last=int(glbk_envsh_scene.map_side)-1;\n"
    "ivec2 tile=at/cells,from=(at-tile*cells)*8;\n"
    "uint place=uint(tile.x)|(uint(tile.y)<<11)|((layer/ENVSH_CHANNELS)<<22);\n"
    "for(int i=0;i<64;i++){\n"
    "ivec2 texel=min(from+ivec2(i&7,i>>3),ivec2(last));\n"
    "float z=envsh_stored(layer%ENVSH_CHANNELS,place,texel);\n"
    "bounds=vec2(min(bounds.x,z),max(bounds.y,z));\n"
    "}\n"
    "}else{\n"
    "for(int i=0;i<4;i++){\n"
    "ivec3 below=ivec3(2*at+ivec2(i&1,i>>1),int(layer));\n"
    "vec2 b=uintBitsToFloat(texelFetch(glbk_envsh_cells,below,0).xy);\n"
    "bounds=vec2(min(bounds.x,b.x),max(bounds.y,b.y));\n"
    "}\n"
    "}\n"
    "result=uvec4(floatBitsToUint(bounds),0u,0u);\n"
    "}\n", 0
};

static const struct { char facts[71];
    char s0[355]; char end; } glbk__glsl_prog_envsh_resolve_frag GLBK__TIGHT = {
    "prog/envsh_resolve.frag\0" "envsh_bindings gbuffer picture envsh_object" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(location=0)out vec4 result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=glbk_picture_at();\n"
    "glbk_point p;\n"
    "bool seen=glbk_read_point(at,p);\n"
    "glbk_picture_show(seen,p.position);\n"
    "vec3 albedo=seen?p.diffuse*(1.-p.metallic):vec3(.0),sum=vec3(.0);\n"
    "if(glbk_envsh_object.lit!=0u)sum=glbk_unpack(texelFetch(glbk_envsh_sum,at,0)).xyz;\n"
    "result=vec4(sum*albedo*.318309886,1.);\n"
    "}\n", 0
};

static const struct { char facts[186];
    char s0[2582]; char end; } glbk__glsl_prog_envsh_shade_comp GLBK__TIGHT = {
    "prog/envsh_shade.comp\0" "envsh_chunk envsh_light envsh_group gbuffer" "\0" "" "\0"
    "ENVSH_FILTER=1 ENVSH_RGBA=0 | ENVSH_FILTER=2 ENVSH_RGBA=1 | ENVSH_FILTER=3 ENVSH_RGBA=0 | ENVSH_FILTER=4 ENVSH_RGBA=1" "\0" "",
    "\n\n\n\n\n\n\nlayout(local_size_x=8,local_size_y=8)in;\n"
    "\nshared uint envsh_all_lit[2],envsh_asked[2];\n"
    "\nstruct envsh_pixel{bool seen;vec3 p,n,flat_n;};\n"
    "\n\n\nenvsh_group envsh_bounds(envsh_pixel pixel)\n"
    "{\n"
    "uint thread=gl_LocalInvocationIndex;\n"
    "vec3 least[6]=vec3[6](pixel.p,pixel.n,pixel.flat_n,-pixel.p,-pixel.n,-pixel.flat_n);\n"
    "for(uint i=0u;i<6u;i++)\n"
    "envsh_chunk[64u*i+thread]=floatBitsToUint(vec4(pixel.seen?least[i]:vec3(3e38),.0));\n"
    "for(uint left=32u;left>0u;left>>=1){\n"
    "barrier();\n"
    "for(uint i=thread;thread<left&&i<384u;i+=64u){\n"
    "vec4 a=uintBitsToFloat(envsh_chunk[i]),b=uintBitsToFloat(envsh_chunk[i+left]);\n"
    "envsh_chunk[i]=floatBitsToUint(min(a,b));\n"
    "}\n"
    "}\n"
    "barrier();\n"
    "for(uint i=0u;i<6u;i++)least[i]=uintBitsToFloat(envsh_chunk[64u*i].xyz);\n"
    "return envsh_group(least[0],-least[3],least[1],-least[4],least[2],-least[5]);\n"
    "}\n"
    "\n\n\nvoid envsh_sort_lights(envsh_query q,envsh_group g,uint from,uint to)\n"
    "{\n"
    "uint thread=gl_LocalInvocationIndex,bit=1u<<(thread&31u);\n"
    "barrier();\n"
    "envsh_load_chunk(from,to);\n"
    "if(thread<2u)envsh_all_lit[thread]=envsh_asked[thread]=0u;\n"
    "barrier();\n"
    "if(from+thread<to){\n"
    "int known=envsh_group_visible(q,g,from+thread);\n"
    "if(known>0)atomicOr(envsh_all_lit[thread>>5],bit);\n"
    "if(known<0)atomicOr(envsh_asked[thread>>5],bit);\n"
    "}\n"
    "barrier();\n"
    "}\n"
    "\n\nuint envsh_take_first(inout uvec2 left)\n"
    "{\n"
    "uint half_of=left.x!=0u?0u:1u,bit=uint(findLSB(left[half_of]));\n"
    "left[half_of]&=left[half_of]-1u;\n"
    "return 32u*half_of+bit;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_GlobalInvocationID.xy),size=textureSize(glbk_gbuffer_place,0);\n"
    "uint first=glbk_envsh_query.first_light,index=uint(at.y)*uint(size.x)+uint(at.x);\n"
    "bool inside=all(lessThan(at,size));\n"
    "envsh_query q=envsh_bound_query();\n"
    "envsh_pixel pixel;\n"
    "glbk_point point;\n"
    "pixel.seen=glbk_read_point(min(at,size-1),point)&&inside;\n"
    "pixel.p=point.position;\n"
    "pixel.n=pixel.seen?point.normal:vec3(.0);\n"
    "pixel.flat_n=pixel.seen?point.geometric:vec3(.0);\n"
    "envsh_group g=envsh_bounds(pixel);\n"
    "uint end=g.low.x<3e38?glbk_envsh_query.end_light:first;\n"
    "vec3 sum=inside&&glbk_envsh_query.adds!=0u?imageLoad(glbk_envsh_total,at).xyz:vec3(.0);\n"
    "for(uint from=first;from<end;from+=64u){\n"
    "envsh_sort_lights(q,g,from,end);\n"
    "for(uvec2 left=uvec2(envsh_all_lit[0],envsh_all_lit[1]);left!=uvec2(0u);){\n"
    "uint light=from+envsh_take_first(left);\n"
    "vec3 d=envsh_direction(light);\n"
    "if(dot(pixel.flat_n,d)>.0)sum+=max(dot(pixel.n,d),.0)*envsh_power(light);\n"
    "}\n"
    "for(uvec2 left=uvec2(envsh_asked[0],envsh_asked[1]);left!=uvec2(0u);){\n"
    "uint light=from+envsh_take_first(left);\n"
    "sum+=envsh_irradiance(q,light,light+1u,pixel.p,pixel.n,pixel.flat_n,index);\n"
    "}\n"
    "}\n"
    "if(inside)imageStore(glbk_envsh_total,at,vec4(sum,.0));\n"
    "}\n", 0
};

static const struct { char facts[162];
    char s0[489]; char end; } glbk__glsl_prog_envsh_shade_frag GLBK__TIGHT = {
    "prog/envsh_shade.frag\0" "envsh_light gbuffer" "\0" "" "\0"
    "ENVSH_FILTER=1 ENVSH_RGBA=0 | ENVSH_FILTER=2 ENVSH_RGBA=1 | ENVSH_FILTER=3 ENVSH_RGBA=0 | ENVSH_FILTER=4 ENVSH_RGBA=1" "\0" "",
    "\n\n\n\n\nlayout(location=0)out glbk_color result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy);\n"
    "vec3 sum=vec3(.0);\n"
    "glbk_point p;\n"
    "if(glbk_envsh_query.adds!=0u)sum=glbk_unpack(texelFetch(glbk_envsh_sum,at,0)).xyz;\n"
    "if(glbk_read_point(at,p)){\n"
    "uint index=uint(at.y)*uint(textureSize(glbk_gbuffer_place,0).x)+uint(at.x);\n"
    "sum+=envsh_irradiance(envsh_bound_query(),glbk_envsh_query.first_light,glbk_envsh_query.end_light,\n"
    "p.position,p.normal,p.geometric,index);\n"
    "}\n"
    "result=glbk_pack(vec4(sum,.0));\n"
    "}\n", 0
};

static const glbk_file glbk__envsh_files[] = {
    { (const char *)&glbk__glsl_lib_envsh_access_glsl },
    { (const char *)&glbk__glsl_lib_envsh_bindings_glsl },
    { (const char *)&glbk__glsl_lib_envsh_cast_glsl },
    { (const char *)&glbk__glsl_lib_envsh_chunk_glsl },
    { (const char *)&glbk__glsl_lib_envsh_disc_glsl },
    { (const char *)&glbk__glsl_lib_envsh_group_glsl },
    { (const char *)&glbk__glsl_lib_envsh_light_glsl },
    { (const char *)&glbk__glsl_lib_envsh_object_glsl },
    { (const char *)&glbk__glsl_lib_envsh_query_glsl },
    { (const char *)&glbk__glsl_lib_envsh_scene_glsl },
    { (const char *)&glbk__glsl_lib_envsh_visible_glsl },
    { (const char *)&glbk__glsl_prog_envsh_cast_frag },
    { (const char *)&glbk__glsl_prog_envsh_cast_vert },
    { (const char *)&glbk__glsl_prog_envsh_cells_frag },
    { (const char *)&glbk__glsl_prog_envsh_resolve_frag },
    { (const char *)&glbk__glsl_prog_envsh_shade_comp },
    { (const char *)&glbk__glsl_prog_envsh_shade_frag }
};


/* ==== src/gl_envshadow/part.h ==== */

/* ---- envsh: this header's GLSL, textures and blocks, by which programs find them ---- */

GLBK__PART_CODE(envsh, ENVSH)

/* ==== src/gl_envshadow/maps.h ==== */

/* ---- envsh: shadow maps: tiles, casters drawn into them, and cells of their depths ---- */

enum {
    GLBK__ENVSH_RECORD = 8,                 /* texels of a light in the table */
    GLBK__ENVSH_CELL = 8,                   /* texels of the atlas a side of a cell */
    GLBK__ENVSH_MAX_SIDE = 8192,            /* the most texels a side of a page */
    GLBK__ENVSH_FAR = 0x3f800000,           /* the bits of 1, the depth where nothing is */
    GLBK__ENVSH_CLIP_DISTANCE0 = 0x3000,    /* GL's CLIP_DISTANCE0 */
    GLBK__ENVSH_DEPTH_CLAMP = 0x864F,       /* GL's DEPTH_CLAMP */
    GLBK__ENVSH_BASE_LEVEL = 0x813C,        /* GL's TEXTURE_BASE_LEVEL */
    GLBK__ENVSH_MAX_LEVEL = 0x813D          /* GL's TEXTURE_MAX_LEVEL */
};

/* Decides where the tiles lie: as square as they can within the greatest page, then on more pages. No page
   means that not even one tile fits. Cells become as many a side as a power of two needs to cover the
   tile. */
static void glbk__envsh_lay_out(const glbk_context *ctx, glbk_envsh_maps *m)
{
    uint32_t side = ctx->max_side < GLBK__ENVSH_MAX_SIDE ? ctx->max_side : (uint32_t)GLBK__ENVSH_MAX_SIDE;
    uint32_t slots = (m->capacity + m->channel_count - 1) / m->channel_count, most = side / m->map_side;
    for (side = 1; side < most && side * side < slots;) side++;
    m->across = slots < side ? slots : side;
    m->down = (slots + m->across - 1) / m->across;
    m->down = m->down < most ? m->down : most;
    m->page_count = m->down ? (slots + m->across * m->down - 1) / (m->across * m->down) : 0;
    for (m->cells_side = 1, m->levels = 1; m->cells_side * GLBK__ENVSH_CELL < m->map_side; m->levels++)
        m->cells_side *= 2;
}

/* Makes textures and framebuffers of maps whose tiles have their places. */
static glbk_result glbk__envsh_create_textures(glbk_context *ctx, glbk_envsh_maps *m)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result;

    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    texture.format = m->channel_count == 4 ? GLBK_FORMAT_RGBA32UI : GLBK_FORMAT_DEPTH32F;
    texture.width = m->across * m->map_side;
    texture.height = m->down * m->map_side;
    texture.layers = m->page_count;
    result = glbk_texture_create(ctx, &texture, &m->atlas);
    target.depth = &m->atlas;
    if (m->channel_count == 4 && result == GLBK_OK) {
        texture.format = GLBK_FORMAT_DEPTH32F;
        texture.layers = 0;
        result = glbk_texture_create(ctx, &texture, &m->depth);
        target.color[0] = &m->atlas;
        target.depth = &m->depth;
    }
    if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &m->atlas_target);
    texture.format = GLBK_FORMAT_RG32UI;
    texture.width = m->across * m->cells_side;
    texture.height = m->down * m->cells_side;
    texture.layers = m->page_count * m->channel_count;
    texture.levels = m->levels;
    if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &m->cells);
    memset(&target, 0, sizeof target);
    target.color[0] = &m->cells;
    if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &m->cell_target);
    if (result == GLBK_OK)
        result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, GLBK__ENVSH_RECORD * (size_t)m->capacity,
                                   &m->views);
    return result;
}

/* Compiles the programs that draw casters and cells. */
static glbk_result glbk__envsh_create_programs(glbk_context *ctx, const glbk_envsh_maps_desc *d,
                                               glbk_envsh_maps *m)
{
    const char *defines = m->channel_count == 4 ? "ENVSH_RGBA=1 GLBK_PLACE" : "ENVSH_RGBA=0 GLBK_PLACE";
    glbk_attributes attributes;
    glbk_result result = glbk__take_attributes(ctx, "glbk_envsh_maps_create", &d->attributes, &attributes);
    if (result == GLBK_OK)
        result = glbk__drawing_program(ctx, glbk_envsh_part(), "envsh_cast.frag", &attributes, defines,
                                       &m->cast);
    if (result == GLBK_OK)
        result = glbk__program_create(ctx, glbk_envsh_part(), "envsh_cells.frag", defines, &m->make_cells);
    return result;
}

/* Checks a desc and writes what it says, with its defaults. */
static glbk_result glbk__envsh_check_desc(const glbk_context *ctx, const glbk_envsh_maps_desc *d,
                                          glbk_envsh_maps *out)
{
    static const char function[] = "glbk_envsh_maps_create";
    const glbk_result bad = GLBK_ERR_DESC, result = glbk__require(ctx, function, "desc", d);
    if (result != GLBK_OK) return result;
    if (!d->capacity || d->capacity > ENVSH_MAX_LIGHTS)
        return glbk__refuse_range(ctx, bad, function, "desc.capacity", d->capacity, 1, ENVSH_MAX_LIGHTS);
    out->capacity = d->capacity;
    out->map_side = d->maps && d->maps->map_side ? d->maps->map_side : 256;
    out->guard = d->maps && d->maps->guard ? d->maps->guard : 4;
    out->channel_count = d->maps && d->maps->rgba ? 4 : 1;
    if (out->map_side < 16 || out->map_side > 4096)
        return glbk__refuse_range(ctx, bad, function, "desc.maps->map_side", out->map_side, 16, 4096);
    if (out->guard > out->map_side / 4)
        return glbk__refuse_range(ctx, bad, function, "desc.maps->guard", out->guard, 1,
                                  out->map_side / 4);
    return GLBK_OK;
}

/* Gives the tiles their places, and checks that pages with them can be made. */
static glbk_result glbk__envsh_check_pages(const glbk_context *ctx, glbk_envsh_maps *m)
{
    static const char function[] = "glbk_envsh_maps_create";
    const uint32_t most = ctx->max_layers < 1024 ? ctx->max_layers : 1024;
    glbk__envsh_lay_out(ctx, m);
    if (!m->page_count)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "desc.maps->map_side", m->map_side, 16,
                                  ctx->max_side);
    if (m->page_count > most)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "pages for desc.capacity: their number",
                                  m->page_count, 1, most);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_envsh_maps_create(glbk_context *ctx, const glbk_envsh_maps_desc *d,
                                            glbk_envsh_maps *out)
{
    glbk_result result;
    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result != GLBK_OK) return result;
    result = glbk__envsh_check_desc(ctx, d, out);
    if (result == GLBK_OK) result = glbk__envsh_check_pages(ctx, out);
    if (result == GLBK_OK) result = glbk__envsh_create_textures(ctx, out);
    if (result == GLBK_OK) result = glbk__envsh_create_programs(ctx, d, out);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_scene), NULL, &out->scene);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_query), NULL, &out->query);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_object), NULL, &out->object);
    if (result != GLBK_OK) glbk_envsh_maps_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_envsh_maps_free(glbk_context *ctx, glbk_envsh_maps *m)
{
    if (!m) return;
    glbk_program_free(ctx, &m->cast);
    glbk_program_free(ctx, &m->make_cells);
    glbk_target_free(ctx, &m->atlas_target);
    glbk_target_free(ctx, &m->cell_target);
    glbk_texture_free(ctx, &m->atlas);
    glbk_texture_free(ctx, &m->depth);
    glbk_texture_free(ctx, &m->cells);
    glbk_texture_free(ctx, &m->views);
    glbk_buffer_free(ctx, &m->scene);
    glbk_buffer_free(ctx, &m->query);
    glbk_buffer_free(ctx, &m->object);
    memset(m, 0, sizeof *m);
}

/* Returns whether the first view was made for tiles of this size: its clip space is its texels times
   2 / map_side. A view of zeros fits tiles of any size. */
static int glbk__envsh_views_fit(const glbk_envsh_maps *m, const envsh_view *view)
{
    const float *lookup = view->lookup;
    int c, best = 0;
    for (c = 1; c < 3; c++)
        if (fabsf(lookup[c]) > fabsf(lookup[best])) best = c;
    return fabsf(view->world_to_clip[4 * best] * (float)m->map_side - 2 * lookup[best]) <=
           1e-3f * fabsf(lookup[best]);
}

/* Writes the eight texels of a light, which docs/gpu-layouts.md lists. */
static void glbk__envsh_record(const glbk_envsh_maps *m, const envsh_view *v, uint32_t light, uint32_t *words)
{
    uint32_t slot = light / m->channel_count, place;
    float f[4 * GLBK__ENVSH_RECORD];
    place = slot % m->across | slot / m->across % m->down << 11 | slot / (m->across * m->down) << 22;
    memcpy(f, v->lookup, sizeof v->lookup);
    memcpy(f + 12, v->right, sizeof v->right);
    f[15] = v->texel[0];
    memcpy(f + 16, v->up, sizeof v->up);
    f[19] = v->texel[1];
    memcpy(f + 20, v->direction, sizeof v->direction);
    f[23] = v->depth_range;
    memcpy(f + 24, v->irradiance, sizeof v->irradiance);
    memcpy(f + 27, &place, sizeof place);
    memcpy(f + 28, v->spread, sizeof v->spread);
    memcpy(words, f, sizeof f);
}

/* Sends the lights' table and the block of the scene to the GPU. */
static glbk_result glbk__envsh_upload(glbk_context *ctx, glbk_envsh_maps *m, const envsh_view *views,
                                      uint32_t count)
{
    glbk_envsh__allocator memory = glbk_envsh__memory(ctx);
    uint32_t *words, i;
    glbk_envsh_scene scene;
    glbk_result result = GLBK_OK;

    words = (uint32_t *)glbk_envsh__alloc_array(&memory, (size_t)count + 1, 4 * 4 * GLBK__ENVSH_RECORD);
    if (!words) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i++)
        glbk__envsh_record(m, &views[i], i, words + 4 * GLBK__ENVSH_RECORD * (size_t)i);
    if (count) result = glbk__table_update(ctx, &m->views, 0, GLBK__ENVSH_RECORD * (size_t)count, words);
    glbk_envsh__free(&memory, words);
    if (result != GLBK_OK) return result;
    memset(&scene, 0, sizeof scene);
    scene.map_side = m->map_side;
    scene.guard = m->guard;
    scene.cells_side = m->cells_side;
    scene.level_count = m->levels;
    scene.light_count = m->count = count;
    scene.clip_per_inside = 2.0f / (float)(m->map_side - 2 * m->guard);
    scene.clip_per_texel_x = 2.0f / (float)(m->across * m->map_side);
    scene.clip_per_texel_y = 2.0f / (float)(m->down * m->map_side);
    return glbk_buffer_update(ctx, &m->scene, 0, sizeof scene, &scene);
}

GLBK_DEF glbk_result glbk_envsh_cast(glbk_context *ctx, glbk_envsh_maps *m, const float transform[16])
{
    const glbk_result result = glbk__require_created(ctx, __func__, "maps", m ? &m->object.name : NULL);
    glbk_envsh_object object;
    int i;
    if (result != GLBK_OK) return result;
    memset(&object, 0, sizeof object);
    if (transform) memcpy(object.transform, transform, sizeof object.transform);
    else
        for (i = 0; i < 4; i++) object.transform[5 * i] = 1.0f;
    object.first_light = m->first;
    object.light_step = m->step;
    m->casts++;
    return glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_object, &m->object, &object);
}

/* Turns clip distances 0 to 3 and the clamp of depths on or off. OpenGL needs them while casters are drawn;
   ES has neither. */
static void glbk__envsh_clip(const glbk_context *ctx, int on)
{
    uint32_t i;
    for (i = 0; !ctx->es && i < 4; i++) glbk__set_cap(ctx, GLBK__ENVSH_CLIP_DISTANCE0 + i, on);
    if (!ctx->es) glbk__set_cap(ctx, GLBK__ENVSH_DEPTH_CLAMP, on);
}

/* Who draws the casters, and into which tiles: those of a page and a channel and, on ES, of a column. */
typedef struct glbk__envsh_casting {
    glbk_envsh_draw_fn draw_fn;
    void    *user;
    uint32_t page;
    uint32_t channel;
    uint32_t column;
    int      reversed;              /* not 0: instance 0 draws for the last light, and so on to the first */
} glbk__envsh_casting;

/* Has the user draw all casters once, into the tiles of lights first, first + step, ... */
static glbk_result glbk__envsh_cast_round(glbk_context *ctx, glbk_envsh_maps *m, const glbk__envsh_casting *c)
{
    static const uint32_t far_bits[4] = { GLBK__ENVSH_FAR, GLBK__ENVSH_FAR, GLBK__ENVSH_FAR,
                                          GLBK__ENVSH_FAR };
    const uint32_t tiles = m->across * m->down, column = c->column, channel = c->channel;
    const uint32_t first = (c->page * tiles + column) * m->channel_count + channel;
    const uint32_t step = (ctx->es ? m->across : 1) * m->channel_count;
    const uint32_t after = (c->page + 1) * tiles * m->channel_count;
    const uint32_t end = after < m->count ? after : m->count;
    uint32_t instances, i;
    glbk_pass pass;
    glbk_result result;

    memset(&pass, 0, sizeof pass);
    pass.target = &m->atlas_target;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_begin(ctx, &pass, &m->cast);
    if (result != GLBK_OK) return result;
    i = m->channel_count == 4;
    glbk__attach(ctx, i ? (uint32_t)GLBK_GL_COLOR_ATTACHMENT0 : (uint32_t)GLBK_GL_DEPTH_ATTACHMENT,
                 &m->atlas, 0, c->page);
    if (!column) glbk_clear_depth(ctx, 1);
    if (i && !column && !channel) ctx->gl.ClearBufferuiv(GLBK_GL_COLOR, 0, far_bits);
    if (first >= end) return GLBK_OK;
    if (i) ctx->gl.ColorMask(channel == 0, channel == 1, channel == 2, channel == 3);
    if (ctx->es)
        ctx->gl.Viewport((int32_t)(column * m->map_side + m->guard), 0, (int32_t)(m->map_side - 2 * m->guard),
                         (int32_t)m->atlas_target.height);
    glbk__envsh_clip(ctx, 1);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_views, &m->views);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_envsh_scene, &m->scene);
    instances = (end - first + step - 1) / step;
    m->first = c->reversed ? first + (instances - 1) * step : first;
    m->step = c->reversed ? 0 - step : step;        /* shaders multiply it modulo 2^32 */
    m->casts = 0;
    result = c->draw_fn(c->user, ctx, m, instances);
    if (!ctx->lost) glbk__envsh_clip(ctx, 0);
    if (ctx->check && result == GLBK_OK && !m->casts)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, "glbk_envsh_maps_render", "draw_fn",
                            "never called glbk_envsh_cast");
    return result;
}

/* Draws all levels of cells of a layer. Each reads the level below, which is the texture's only one
   meanwhile, since a level must not be read while it is drawn. */
static glbk_result glbk__envsh_cell_layer(glbk_context *ctx, glbk_envsh_maps *m, uint32_t layer)
{
    glbk_envsh_object object;
    glbk_pass pass;
    glbk_result result = GLBK_OK;
    uint32_t level;

    memset(&object, 0, sizeof object);
    memset(&pass, 0, sizeof pass);
    pass.target = &m->cell_target;
    object.layer = layer;
    for (level = 0; level < m->levels && result == GLBK_OK; level++) {
        const int32_t below = level ? (int32_t)level - 1 : 0;
        object.level = level;
        pass.viewport[2] = (int32_t)(m->cells.width >> level);
        pass.viewport[3] = (int32_t)(m->cells.height >> level);
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_object, &m->object, &object);
        if (result == GLBK_OK) result = glbk_begin(ctx, &pass, &m->make_cells);
        if (result != GLBK_OK) break;
        glbk__attach(ctx, GLBK_GL_COLOR_ATTACHMENT0, &m->cells, level, layer);
        glbk_bind_texture(ctx,
                          m->channel_count == 4 ? GLBK_SLOT_glbk_envsh_depth4 : GLBK_SLOT_glbk_envsh_depth,
                          &m->atlas);
        glbk_bind_block(ctx, GLBK_SLOT_glbk_envsh_scene, &m->scene);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_cells, &m->cells);
        ctx->gl.TexParameteri(m->cells.gl_target, GLBK__ENVSH_BASE_LEVEL, below);
        ctx->gl.TexParameteri(m->cells.gl_target, GLBK__ENVSH_MAX_LEVEL, below);
        if (!level) glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_cells, NULL);  /* it reads none */
        glbk_draw_screen(ctx);
    }
    if (ctx->lost) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_cells, &m->cells);
    ctx->gl.TexParameteri(m->cells.gl_target, GLBK__ENVSH_BASE_LEVEL, 0);
    ctx->gl.TexParameteri(m->cells.gl_target, GLBK__ENVSH_MAX_LEVEL, (int32_t)m->levels - 1);
    return result;
}

/* Returns how many pages the maps of the frame fill, at least in part. */
static uint32_t glbk__envsh_page_count(const glbk_envsh_maps *m)
{
    const uint32_t page = m->across * m->down * m->channel_count;
    return (m->count + page - 1) / page;
}

/* Draws all maps and their cells. */
static glbk_result glbk__envsh_draw_all(glbk_context *ctx, glbk_envsh_maps *m, glbk__envsh_casting *c)
{
    const uint32_t pages = glbk__envsh_page_count(m), columns = ctx->es ? m->across : 1;
    glbk_result result = GLBK_OK;
    uint32_t layer;

    for (c->page = 0; c->page < pages; c->page++)
        for (c->channel = 0; c->channel < m->channel_count; c->channel++)
            for (c->column = 0; c->column < columns && result == GLBK_OK; c->column++)
                result = glbk__envsh_cast_round(ctx, m, c);
    for (layer = 0; layer < pages * m->channel_count && result == GLBK_OK; layer++)
        result = glbk__envsh_cell_layer(ctx, m, layer);
    return result;
}

/* Writes for each layer a number that all its cells of the finest level determine. */
static glbk_result glbk__envsh_digest_cells(glbk_context *ctx, glbk_envsh_maps *m, uint64_t *digests)
{
    const uint32_t layers = glbk__envsh_page_count(m) * m->channel_count;
    const uint32_t wide = m->cells.width, high = m->cells.height;
    const glbk_envsh__allocator memory = glbk_envsh__memory(ctx);
    uint32_t *cells = (uint32_t *)glbk_envsh__alloc_array(&memory, (size_t)wide * high, 16), layer;
    glbk_result result = cells ? GLBK_OK : GLBK_ERR_ALLOC;
    glbk_pass pass;
    size_t i;

    memset(&pass, 0, sizeof pass);
    pass.target = &m->cell_target;
    for (layer = 0; layer < layers && result == GLBK_OK; layer++) {
        result = glbk_begin(ctx, &pass, &m->make_cells);
        if (result != GLBK_OK) break;
        glbk__attach(ctx, GLBK_GL_COLOR_ATTACHMENT0, &m->cells, 0, layer);
        result = glbk_target_read(ctx, &m->cell_target, 0, 0, 0, wide, high, cells);
        digests[layer] = 1;
        for (i = 0; i < 4 * (size_t)wide * high && result == GLBK_OK; i++)
            digests[layer] = (digests[layer] ^ cells[i]) * 0x9e3779b97f4a7c15u;
    }
    glbk_envsh__free(&memory, cells);
    return result;
}

/* Finds out whether draw_fn drew all instances, with desc.check of the context: draws the maps once more,
   with the instances in the opposite order. If each instance of each caster is drawn, the maps are the same
   again. If only the first ones are, other lights get them now. */
static glbk_result glbk__envsh_check_instances(glbk_context *ctx, glbk_envsh_maps *m, glbk__envsh_casting *c)
{
    const uint32_t layers = glbk__envsh_page_count(m) * m->channel_count;
    const glbk_envsh__allocator memory = glbk_envsh__memory(ctx);
    uint64_t *digests = (uint64_t *)glbk_envsh__alloc_array(&memory, (size_t)layers + 1, 2 * sizeof *digests);
    glbk_result result = digests ? GLBK_OK : GLBK_ERR_ALLOC;

    if (result == GLBK_OK) result = glbk__envsh_digest_cells(ctx, m, digests);
    c->reversed = 1;
    if (result == GLBK_OK) result = glbk__envsh_draw_all(ctx, m, c);
    if (result == GLBK_OK) result = glbk__envsh_digest_cells(ctx, m, digests + layers);
    if (result == GLBK_OK && memcmp(digests, digests + layers, layers * sizeof *digests) != 0)
        result = glbk__refuse(ctx, GLBK_ERR_ORDER, "glbk_envsh_maps_render", "draw_fn",
                              "drew fewer instances of a caster than it was given");
    glbk_envsh__free(&memory, digests);
    return result;
}

GLBK_DEF glbk_result glbk_envsh_maps_render(glbk_context *ctx, glbk_envsh_maps *m, const envsh_view *views,
                                            uint32_t count, glbk_envsh_draw_fn draw_fn, void *user)
{
    glbk_result result = glbk__require_created(ctx, __func__, "maps", m ? &m->views.name : NULL);
    glbk__envsh_casting casting;

    if (result == GLBK_OK && count) result = glbk__require(ctx, __func__, "views", views);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "draw_fn", draw_fn ? m : NULL);
    if (result != GLBK_OK) return result;
    if (count > m->capacity)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, __func__, "count", count, 0, m->capacity);
    if (count && !glbk__envsh_views_fit(m, views))
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, __func__, "maps->map_side", m->map_side,
                                  "the map_side of the envsh_maps_desc that made the views");
    if (count && views->guard && views->guard != m->guard)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, __func__, "maps->guard", m->guard,
                                  "the guard of the envsh_maps_desc that made the views");
    m->count = 0;
    memset(&casting, 0, sizeof casting);
    casting.draw_fn = draw_fn;
    casting.user = user;
    result = glbk__envsh_upload(ctx, m, views, count);
    if (result == GLBK_OK) result = glbk__envsh_draw_all(ctx, m, &casting);
    if (result == GLBK_OK && ctx->check) result = glbk__envsh_check_instances(ctx, m, &casting);
    if (result != GLBK_OK) m->count = 0;
    return result;
}

/* ==== src/gl_envshadow/queries.h ==== */

/* ---- envsh: queries: settings checked, and bound with the maps for shaders ---- */

/* Returns what a setting means: 0 if it is negative, the default if it is 0. */
static float glbk__envsh_or_default(float value, float standard)
{
    return value < 0 ? 0.0f : value == 0 ? standard : value;
}

/* Writes a query with its defaults, or says which field is out of range, as envshadow.h's checks do. */
static glbk_result glbk__envsh_query_of(const glbk_context *ctx, const char *function,
                                        const envsh_query *from, envsh_query *q)
{
    static const float most[] = { 0, 0, 8, 32, 64 };     /* the greatest radius of each filter */
    memset(q, 0, sizeof *q);
    if (from) *q = *from;
    if ((unsigned)q->filter >= ENVSH_FILTER_COUNT)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "query.filter", q->filter, 0,
                                  ENVSH_FILTER_COUNT - 1);
    if (q->filter == ENVSH_FILTER_DEFAULT) q->filter = ENVSH_FILTER_PENUMBRA;
    if (!(q->bias <= 1e6f))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "query.bias", (double)q->bias,
                                  "at most 1e6 texels");
    q->bias = glbk__envsh_or_default(q->bias, 1);
    if (!q->tap_count) q->tap_count = 16;
    if (q->filter == ENVSH_FILTER_PLAIN) {
        q->tap_count = 1;
        q->radius = q->extent_scale = 0;
        return GLBK_OK;
    }
    if (!(q->radius <= most[q->filter]) ||
        (q->filter == ENVSH_FILTER_SMOOTH && q->radius < 0.5f && q->radius != 0))
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "query.radius", (double)q->radius,
                                  q->filter == ENVSH_FILTER_SMOOTH ? 0.5 : 0, (double)most[q->filter]);
    q->radius = glbk__envsh_or_default(q->radius, q->filter == ENVSH_FILTER_PENUMBRA ? 12.0f : 2.0f);
    if (q->filter == ENVSH_FILTER_SMOOTH) return GLBK_OK;
    if (q->tap_count > ENVSH_MAX_TAPS)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "query.tap_count", q->tap_count, 0,
                                 ENVSH_MAX_TAPS);
    if (!(q->extent_scale <= 1e6f))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "query.extent_scale", (double)q->extent_scale,
                                  "at most 1e6");
    q->extent_scale = glbk__envsh_or_default(q->extent_scale, 1);
    return GLBK_OK;
}

/* Fills the block of a query. The taps lie on Vogel's spiral, each turned by the golden angle from the one
   before. */
static void glbk__envsh_fill_query(const envsh_query *q, glbk_envsh_query *out)
{
    const double cosine = -0.73736887807831990, sine = 0.67549029426152364;
    double x = 1, y = 0, t;
    uint32_t i;
    memset(out, 0, sizeof *out);
    out->radius = q->radius;
    out->bias = q->bias;
    out->extent_scale = q->extent_scale;
    out->taps = q->tap_count;
    out->seed = q->seed;
    for (i = 0; i < q->tap_count && i < ENVSH_MAX_TAPS; i++) {
        float radius = sqrtf(((float)i + 0.5f) / (float)q->tap_count);
        out->disc[2 * i] = radius * (float)x;
        out->disc[2 * i + 1] = radius * (float)y;
        t = x * cosine - y * sine;
        y = x * sine + y * cosine;
        x = t;
    }
}

/* Binds all that shaders read of maps. */
static void glbk__envsh_bind_all(glbk_context *ctx, const glbk_envsh_maps *m, const glbk_offset *offset)
{
    const glbk_offset at = glbk__offset(offset);
    const uint32_t atlas = m->channel_count == 4 ? GLBK_SLOT_glbk_envsh_depth4 : GLBK_SLOT_glbk_envsh_depth;
    glbk_bind_texture(ctx, at.unit + atlas, &m->atlas);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_envsh_cells, &m->cells);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_envsh_views, &m->views);
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_envsh_scene, &m->scene);
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_envsh_query, &m->query);
}

GLBK_DEF glbk_result glbk_envsh_bind(glbk_context *ctx, glbk_envsh_maps *m, const envsh_query *query,
                                     const glbk_offset *offset)
{
    glbk_envsh_query values;
    envsh_query q;
    glbk_result result = glbk__require_created(ctx, __func__, "maps", m ? &m->query.name : NULL);
    if (result == GLBK_OK) result = glbk__envsh_query_of(ctx, __func__, query, &q);
    if (result != GLBK_OK) return result;
    glbk__envsh_fill_query(&q, &values);
    result = glbk__put_block(ctx, glbk__offset(offset).block + GLBK_SLOT_glbk_envsh_query, &m->query,
                             &values);
    if (result == GLBK_OK) glbk__envsh_bind_all(ctx, m, offset);
    return result;
}

/* ==== src/gl_envshadow/renderer.h ==== */

/* ---- envsh: the renderer: light of all maps, summed up pixel by pixel ---- */

GLBK_DEF glbk_result glbk_envsh_renderer_create(glbk_context *ctx, const glbk_envsh_renderer_desc *d,
                                                glbk_envsh_renderer *out)
{
    glbk_result result;

    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "desc", d);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "desc.width", d->width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "desc.height", d->height);
    if (result != GLBK_OK) return result;
    out->width = d->width;
    out->height = d->height;
    out->compute = ctx->compute;
    result = glbk__sums_create(ctx, out->compute, d->width, d->height, out->sums, out->targets);
    if (result == GLBK_OK)
        result = glbk__gbuffer_program(ctx, glbk_envsh_part(), "envsh_resolve.frag", NULL, &out->resolve);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_object), NULL, &out->object);
    if (result != GLBK_OK) glbk_envsh_renderer_free(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_envsh_renderer_resize(glbk_context *ctx, glbk_envsh_renderer *r, uint32_t width,
                                                uint32_t height)
{
    glbk_result result =
        glbk__require_created(ctx, __func__, "renderer", r ? &r->targets[0].name : NULL);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "width", width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "height", height);
    if (result != GLBK_OK) return result;
    glbk__sums_free(ctx, r->sums, r->targets);
    r->begun = 0;
    r->width = width;
    r->height = height;
    result = glbk__sums_create(ctx, r->compute, width, height, r->sums, r->targets);
    if (result != GLBK_OK) glbk_envsh_renderer_free(ctx, r);
    return result;
}

GLBK_DEF void glbk_envsh_renderer_free(glbk_context *ctx, glbk_envsh_renderer *r)
{
    uint32_t i;
    if (!r) return;
    for (i = 0; i < 2 * ENVSH_FILTER_COUNT; i++) glbk_program_free(ctx, &r->shade[i]);
    glbk_program_free(ctx, &r->resolve);
    glbk__sums_free(ctx, r->sums, r->targets);
    glbk_buffer_free(ctx, &r->object);
    memset(r, 0, sizeof *r);
}

/* Checks that a renderer and a G-buffer were created, and for pictures of one size. */
static glbk_result glbk__envsh_fits(const glbk_context *ctx, const char *function,
                                    const glbk_envsh_renderer *r, const glbk_gbuffer *g)
{
    const glbk_result result =
        glbk__require_created(ctx, function, "renderer", r ? &r->targets[0].name : NULL);
    return result == GLBK_OK ? glbk__require_gbuffer(ctx, function, g, r->width, r->height) : result;
}

/* Finds the program of a filter, which is compiled when it is first asked for. */
static glbk_result glbk__envsh_shade_program(glbk_context *ctx, glbk_envsh_renderer *r, uint32_t filter,
                                             uint32_t rgba, glbk_program **out)
{
    char defines[] = "ENVSH_FILTER=0 ENVSH_RGBA=0";
    *out = &r->shade[2 * filter + rgba];
    if ((*out)->name) return GLBK_OK;
    defines[13] = (char)('0' + filter);
    defines[26] = (char)('0' + rgba);
    return glbk__gbuffer_program(ctx, glbk_envsh_part(), r->compute ? "envsh_shade.comp" : "envsh_shade.frag",
                                 defines, *out);
}

/* Adds the light of the lights that m->query names. */
static glbk_result glbk__envsh_shade_pass(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_gbuffer *g,
                                          const glbk_envsh_maps *m, glbk_program *program)
{
    glbk_result result;
    glbk_pass pass;

    memset(&pass, 0, sizeof pass);
    pass.target = &r->targets[!r->now];
    result = r->compute ? GLBK_OK : glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    glbk__envsh_bind_all(ctx, m, NULL);
    (void)glbk_gbuffer_bind(ctx, g, NULL);
    if (r->compute) {
        glbk_bind_image(ctx, GLBK_SLOT_glbk_envsh_total, &r->sums[0]);
        result = glbk_dispatch(ctx, program, (r->width + 7) / 8, (r->height + 7) / 8, 1);
    } else {
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_sum, &r->sums[r->now]);
        glbk_draw_screen(ctx);
        r->now = !r->now;
    }
    if (result == GLBK_OK) r->begun = 1;
    return result;
}

/* Adds the light of all maps, by a query that has its defaults, in as many passes as it takes. */
static glbk_result glbk__envsh_shade_all(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_gbuffer *g,
                                         glbk_envsh_maps *m, const envsh_query *q, uint32_t lights_per_pass)
{
    glbk_envsh_query values;
    glbk_program *program;
    glbk_result result =
        glbk__envsh_shade_program(ctx, r, (uint32_t)q->filter, m->channel_count == 4, &program);
    uint32_t from = 0;

    if (result != GLBK_OK) return result;
    if (!q->add) r->begun = 0;
    if (!lights_per_pass) lights_per_pass = ENVSH_MAX_LIGHTS;
    glbk__envsh_fill_query(q, &values);
    for (; from < m->count && result == GLBK_OK; from = values.end_light) {
        values.first_light = from;
        values.end_light = m->count - from < lights_per_pass ? m->count : from + lights_per_pass;
        values.adds = r->begun != 0;
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_query, &m->query, &values);
        if (result == GLBK_OK) result = glbk__envsh_shade_pass(ctx, r, g, m, program);
    }
    return result;
}

GLBK_DEF glbk_result glbk_envsh_shade(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_gbuffer *g,
                                      glbk_envsh_maps *m, const envsh_query *query, uint32_t lights_per_pass)
{
    envsh_query q;
    glbk_result result = glbk__envsh_fits(ctx, __func__, r, g);
    if (result == GLBK_OK) result = glbk__require_created(ctx, __func__, "maps", m ? &m->query.name : NULL);
    if (result == GLBK_OK) result = glbk__envsh_query_of(ctx, __func__, query, &q);
    return result == GLBK_OK ? glbk__envsh_shade_all(ctx, r, g, m, &q, lights_per_pass) : result;
}

GLBK_DEF glbk_result glbk_envsh_illuminate(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_gbuffer *g,
                                           glbk_envsh_maps *m, const glbk_envsh_frame *f)
{
    envsh_query q;
    uint32_t first = 0, n;
    glbk_result result = glbk__envsh_fits(ctx, __func__, r, g);
    if (result == GLBK_OK) result = glbk__require_created(ctx, __func__, "maps", m ? &m->query.name : NULL);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "frame", f);
    if (result == GLBK_OK && f->view_count) result = glbk__require(ctx, __func__, "frame.views", f->views);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "frame.draw_fn", f->draw_fn ? f : NULL);
    if (result == GLBK_OK) result = glbk__envsh_query_of(ctx, __func__, f->query, &q);
    if (result != GLBK_OK) return result;
    do {
        n = f->view_count - first < m->capacity ? f->view_count - first : m->capacity;
        q.add = first != 0;
        result = glbk_envsh_maps_render(ctx, m, n ? f->views + first : NULL, n, f->draw_fn, f->user);
        if (result == GLBK_OK) result = glbk__envsh_shade_all(ctx, r, g, m, &q, 0);
        first += n;
    } while (first < f->view_count && result == GLBK_OK);
    return result;
}

GLBK_DEF glbk_result glbk_envsh_resolve(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_gbuffer *g,
                                        const glbk_pass *pass, const glbk_picture *picture)
{
    glbk_envsh_object object;
    glbk_result result = glbk__envsh_fits(ctx, __func__, r, g);

    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "pass", pass);
    if (result != GLBK_OK) return result;
    memset(&object, 0, sizeof object);
    object.lit = r->begun != 0;
    result = glbk__begin_picture(ctx, __func__, pass, picture, r->width, r->height, &r->resolve);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_object, &r->object, &object);
    if (result != GLBK_OK) return result;
    (void)glbk_gbuffer_bind(ctx, g, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_sum, &r->sums[r->now]);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_envsh_read(glbk_context *ctx, glbk_envsh_renderer *r, float *rgba)
{
    glbk_result result = glbk__require_created(ctx, __func__, "renderer", r ? &r->targets[0].name : NULL);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "rgba", rgba);
    if (result != GLBK_OK) return result;
    if (r->begun) return glbk_target_read(ctx, &r->targets[r->now], 0, 0, 0, r->width, r->height, rgba);
    memset(rgba, 0, 16 * (size_t)r->width * r->height);
    return GLBK_OK;
}

/* ==== src/gl_envshadow/end.h ==== */

#endif /* GL_ENVSHADOW_IMPLEMENTATION */

/*
Dapple is available under either of the two licences below, at your choice:
MIT-0 OR Unlicense.

------------------------------------------------------------------------------
MIT No Attribution

Copyright 2026 The Dapple authors

Permission is hereby granted, free of charge, to any person obtaining a copy
of this software and associated documentation files (the "Software"), to deal
in the Software without restriction, including without limitation the rights
to use, copy, modify, merge, publish, distribute, sublicense, and/or sell
copies of the Software, and to permit persons to whom the Software is
furnished to do so.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR
IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY,
FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER
LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM,
OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE
SOFTWARE.

------------------------------------------------------------------------------
The Unlicense

This is free and unencumbered software released into the public domain.

Anyone is free to copy, modify, publish, use, compile, sell, or distribute
this software, either in source code form or as a compiled binary, for any
purpose, commercial or non-commercial, and by any means.

In jurisdictions that recognize copyright laws, the author or authors of this
software dedicate any and all copyright interest in the software to the public
domain. We make this dedication for the benefit of the public at large and to
the detriment of our heirs and successors. We intend this dedication to be an
overt act of relinquishment in perpetuity of all present and future rights to
this software under copyright law.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR
IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY,
FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
AUTHORS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN
ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION
WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.

For more information, please refer to <https://unlicense.org/>
*/
