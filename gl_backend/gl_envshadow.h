/* gl_envshadow.h - v0.9.0 - environment-map shadows on OpenGL 3.3, OpenGL ES 3.0 and WebGL 2 - MIT-0 OR Unlicense

   What it does

   Draws the shadow maps of a sky's lights through a callback of yours, all in one atlas: envsh_light() in shaders of
   your own, or complete passes that light a G-buffer with all of them, or with clusters of lights one after the other.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, programs, textures and targets, and whose
     conventions, errors and rules about GL's state hold here; and gl_gbuffer.h, for the complete passes.
   - It chooses no lights: envlights.h does, or you; envshadow.h lays out their maps.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #define GL_ENVSHADOW_IMPLEMENTATION
       #include "gl_backend/gl_envshadow.h"
       #include <stdio.h>
       #include <string.h>

       // With GLFW: return glfwGetProcAddress(name);  with EGL: return eglGetProcAddress(name);
       static glbk_proc_fn get_proc(const char *name, void *user)
       {
           (void)name; (void)user;
           return NULL;                                     // no GL here: init says so below
       }

       int main(void)
       {
           static const char fragment[] =                   // a shader of yours that calls a function of the library
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

   Configuration

     GL_ENVSHADOW_IMPLEMENTATION   in one source file: compiles the code; another file may have gl_backend.h's

   Layouts: docs/gpu-layouts.md.   The technique: docs/envshadow.md.   State: docs/gl-state.md.
   Licence: end of file. */
/* Not inside the guard: their implementations may be wanted at the second time. envshadow.h lies above this folder. */
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

/* ==== src/gl_envshadow/api.h ==== */

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

/* ==== src/gl_envshadow/begin.h ==== */

/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_ENVSHADOW_H */

/* ==== implementation ============================================================================================== */

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

/* *out = a * b and 1, or 0 and *out untouched where the product does not fit. */
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

/* NULL where the size is 0 or overflows, so that a caller has one thing to test. */
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


static const char *const glbk__glsl_lib_envsh_access_glsl[] = {
    "\n\n#ifndef ENVSH_RGBA\n"
    "#error \"ENVSH_RGBA: 1 where four maps share a texel (glbk_envsh_maps_desc.rgba), else 0\"\n"
    "#endif\n"
    "#ifndef ENVSH_TEXEL\n"
    "#define ENVSH_TEXEL(i) texelFetch(glbk_envsh_views, glbk_table_at(i), 0)\n"
    "#endif\n"
    "#define ENVSH_STORED(view, at) envsh_stored(view.light, view.place, at)\n"
    "#define ENVSH_CELL(view, at, level) envsh_cell(view.light, view.place, at, level)\n"
    "\nivec2 envsh_slot(uint place){return ivec2(uvec2(place&2047u,(place>>11)&2047u));}\n"
    "\nfloat envsh_stored(uint light,uint place,ivec2 at)\n"
    "{\n"
    "ivec3 texel=ivec3(envsh_slot(place)*int(glbk_envsh_scene.tiles.x)+at,int(place>>22));\n"
    "#if ENVSH_RGBA\n"
    "return uintBitsToFloat(texelFetch(glbk_envsh_depth4,texel,0)[light&3u]);\n"
    "#else\n"
    "return texelFetch(glbk_envsh_depth,texel,0).x;\n"
    "#endif\n"
    "}\n"
    "\nvec2 envsh_cell(uint light,uint place,ivec2 at,int level)\n"
    "{\n"
    "uint channels=ENVSH_RGBA==1?4u:1u;\n"
    "int layer=int((place>>22)*channels+(light&(channels-1u)));\n"
    "ivec2 corner=envsh_slot(place)*(int(glbk_envsh_scene.tiles.w)>>level);\n"
    "return uintBitsToFloat(texelFetch(glbk_envsh_cells,ivec3(corner+at,layer),level).xy);\n"
    "}\n"
};

static const char *const glbk__glsl_lib_envsh_bindings_glsl[] = {
    "\nuniform sampler2DArray glbk_envsh_depth;\n"
    "uniform usampler2DArray glbk_envsh_depth4;\n"
    "uniform usampler2DArray glbk_envsh_cells;\n"
    "uniform usampler2DArray glbk_envsh_views;\n"
    "uniform glbk_color_sampler glbk_envsh_sum;\n"
    "#if __VERSION__ >= 430\n"
    "layout(rgba32f,binding=0)restrict uniform image2D glbk_envsh_total;\n"
    "#endif\n"
};

static const char *const glbk__glsl_lib_envsh_cast_glsl[] = {
    "\n\n\n\n\n#ifndef ENVSH_RGBA\n"
    "#error \"ENVSH_RGBA: 1 where four maps share a texel (glbk_envsh_maps_desc.rgba), else 0\"\n"
    "#endif\n"
    "\nstruct envsh_vertex{vec4 position,inside;float depth;};\n"
    "\n\n\nenvsh_vertex envsh_cast(int instance,vec3 world)\n"
    "{\n"
    "uint at=8u*(glbk_envsh_object.lights.x+glbk_envsh_object.lights.y*uint(instance));\n"
    "vec4 p=vec4(world,1.0);\n"
    "uvec4 tiles=glbk_envsh_scene.tiles;\n"
    "vec2 texel=vec2(dot(uintBitsToFloat(texelFetch(glbk_envsh_views,glbk_table_at(at),0)),p),\n"
    "dot(uintBitsToFloat(texelFetch(glbk_envsh_views,glbk_table_at(at+1u),0)),p));\n"
    "uint place=texelFetch(glbk_envsh_views,glbk_table_at(at+6u),0).w;\n"
    "vec2 corner=vec2(uvec2(place&2047u,(place>>11)&2047u)*tiles.x);\n"
    "envsh_vertex v;\n"
    "v.depth=dot(uintBitsToFloat(texelFetch(glbk_envsh_views,glbk_table_at(at+2u),0)),p);\n"
    "v.inside=vec4(texel-float(tiles.y),float(tiles.x-tiles.y)-texel);\n"
    "#ifdef GL_ES\n"
    "vec2 inner=v.inside.xy*glbk_envsh_scene.page.z-1.0;\n"
    "v.position=vec4(inner.x,(corner.y+texel.y)*glbk_envsh_scene.page.y-1.0,inner.y,1.0);\n"
    "#else\n"
    "v.position=vec4((corner+texel)*glbk_envsh_scene.page.xy-1.0,2.0*v.depth-1.0,1.0);\n"
    "#endif\n"
    "return v;\n"
    "}\n"
    "\n#ifdef GL_ES\n"
    "#define ENVSH_CLIP(d)\n"
    "#define ENVSH_WRITE_DEPTH(depth) gl_FragDepth = clamp(depth, 0.0, 1.0);\n"
    "#else\n"
    "#define ENVSH_CLIP_PART(i, d) gl_ClipDistance[i] = d;\n"
    "#define ENVSH_CLIP(d) ENVSH_CLIP_PART(0, d.x) ENVSH_CLIP_PART(1, d.y) ENVSH_CLIP_PART(2, d.z) ENVSH_CLIP_PART(3, d.w)\n"
    "#define ENVSH_WRITE_DEPTH(depth)\n"
    "#endif\n"
    "#define ENVSH_SET(v) gl_Position = v.position; envsh_depth = v.depth; ENVSH_CLIP(v.inside)\n"
    "#define ENVSH_CAST(world) { envsh_vertex envsh_v = envsh_cast(gl_InstanceID, world); ENVSH_SET(envsh_v) }\n"
    "\n#if ENVSH_RGBA\n"
    "#define ENVSH_STORE(depth) { envsh_bits = uvec4(floatBitsToUint(clamp(depth, 0.0, 1.0))); ENVSH_WRITE_DEPTH(depth) }\n"
    "#else\n"
    "#define ENVSH_STORE(depth) { ENVSH_WRITE_DEPTH(depth) }\n"
    "#endif\n"
};

static const char *const glbk__glsl_lib_envsh_chunk_glsl[] = {
    "\n\n\n\n#define ENVSH_TEXEL(i) envsh_chunk[((i) & 504u) | (((i) ^ ((i) >> 3)) & 7u)]\n"
    "shared uvec4 envsh_chunk[512];\n"
    "\nvoid envsh_load_chunk(uint from,uint to)\n"
    "{\n"
    "for(uint i=8u*from+gl_LocalInvocationIndex;i<8u*min(from+64u,to);i+=64u)\n"
    "ENVSH_TEXEL(i)=texelFetch(glbk_envsh_views,glbk_table_at(i),0);\n"
    "}\n"
};

static const char *const glbk__glsl_lib_envsh_disc_glsl[] = {
    "\n\n#define ENVSH_DISC(i) (((i) & 1u) != 0u ? glbk_envsh_query.disc[(i) >> 1].zw : glbk_envsh_query.disc[(i) >> 1].xy)\n"
};

static const char *const glbk__glsl_lib_envsh_group_glsl[] = {
    "\n\n\n\nstruct envsh_group{vec3 low,high,n_low,n_high,flat_low,flat_high;};\n"
    "\n\nbool envsh_all_under(vec3 low,vec3 high,vec3 d){return dot(max(low*d,high*d),vec3(1.0))< -1e-5;}\n"
    "\n\nvec2 envsh_group_reach(envsh_query q,envsh_view v,float z)\n"
    "{\n"
    "#if ENVSH_FILTER == 1\n"
    "return vec2(0.01);\n"
    "#elif ENVSH_FILTER == 2\n"
    "return vec2(q.radius+1.01);\n"
    "#elif ENVSH_FILTER == 3\n"
    "return vec2(q.radius+0.01);\n"
    "#else\n"
    "vec2 a,b;\n"
    "envsh_kernel(q,v,z,a,b);\n"
    "return abs(a)+abs(b)+0.71;\n"
    "#endif\n"
    "}\n"
    "\n\n\nint envsh_group_visible(envsh_query q,envsh_group g,uint light)\n"
    "{\n"
    "vec3 d=envsh_direction(light),center=0.5*(g.low+g.high),extent=0.5*(g.high-g.low);\n"
    "if(envsh_all_under(g.n_low,g.n_high,d)||envsh_all_under(g.flat_low,g.flat_high,d))return 0;\n"
    "envsh_view v=envsh_read_view(light);\n"
    "extent+=1.01*q.bias*max(v.texel.x,v.texel.y);\n"
    "if(!all(lessThan(extent,vec3(1e15))))return-1;\n"
    "vec4 middle=vec4(center,1.0),wide=vec4(extent,0.0)+1e-6*vec4(abs(center)+extent,1.0);\n"
    "vec2 at=vec2(dot(v.row_x,middle),dot(v.row_y,middle));\n"
    "vec2 across=vec2(dot(abs(v.row_x),wide),dot(abs(v.row_y),wide));\n"
    "float z=dot(v.row_z,middle),deep=dot(abs(v.row_z),wide);\n"
    "vec3 n=0.5*(g.flat_low+g.flat_high),n_extent=0.5*(g.flat_high-g.flat_low);\n"
    "vec2 flat_n=abs(vec2(dot(n,v.right),dot(n,v.up)));\n"
    "flat_n+=vec2(dot(n_extent,abs(v.right)),dot(n_extent,abs(v.up)));\n"
    "float cosine=max(dot(n,d)-dot(n_extent,abs(d)),0.1);\n"
    "vec2 reach=envsh_group_reach(q,v,z+deep);\n"
    "float slope=1.001*dot(flat_n*v.texel,reach+1.0)/(cosine*v.depth_range);\n"
    "return envsh_decide_box(q,v,at,across+reach,z-deep-min(slope,1.001*envsh_plane_limit(q,v)),\n"
    "z+deep+slope);\n"
    "}\n"
};

static const char *const glbk__glsl_lib_envsh_light_glsl[] = {
    "\n\nenvsh_query envsh_bound_query()\n"
    "{\n"
    "vec4 values=glbk_envsh_query.values;\n"
    "return envsh_query(values.x,values.y,values.z,glbk_envsh_query.numbers.x,glbk_envsh_query.numbers.y,\n"
    "int(glbk_envsh_scene.tiles.x),int(glbk_envsh_scene.range.y));\n"
    "}\n"
    "\n\nvec3 envsh_light(vec3 p,vec3 n,vec3 flat_n,uint index)\n"
    "{\n"
    "return envsh_irradiance(envsh_bound_query(),0u,glbk_envsh_scene.range.x,p,n,flat_n,index);\n"
    "}\n"
};

static const char *const glbk__glsl_lib_envsh_object_glsl[] = {
    "\nlayout(std140)uniform glbk_envsh_object_block{\n"
    "mat4 world;\n"
    "uvec4 lights;\n"
    "}glbk_envsh_object;\n"
};

static const char *const glbk__glsl_lib_envsh_query_glsl[] = {
    "\nlayout(std140)uniform glbk_envsh_query_block{\n"
    "vec4 values;\n"
    "uvec4 numbers;\n"
    "uvec4 range;\n"
    "vec4 disc[32];\n"
    "}glbk_envsh_query;\n"
};

static const char *const glbk__glsl_lib_envsh_scene_glsl[] = {
    "\nlayout(std140)uniform glbk_envsh_scene_block{\n"
    "uvec4 tiles;\n"
    "uvec4 range;\n"
    "vec4 page;\n"
    "}glbk_envsh_scene;\n"
};

static const char *const glbk__glsl_lib_envsh_visible_glsl[] = {
    "\n\n\n\n\n\n\n\n#if !(defined ENVSH_FILTER && defined ENVSH_TEXEL && defined ENVSH_STORED && defined ENVSH_CELL && defined ENVSH_DISC)\n"
    "#error \"envsh_visible: ENVSH_FILTER, ENVSH_TEXEL, ENVSH_STORED, ENVSH_CELL, ENVSH_DISC\"\n"
    "#endif\n"
    "#if ENVSH_FILTER == 0\n"
    "#undef ENVSH_FILTER\n"
    "#define ENVSH_FILTER 4\n"
    "#endif\n"
    "\nstruct envsh_query{\n"
    "float radius,bias,extent_scale;\n"
    "uint taps,seed;\n"
    "int size,levels;\n"
    "};\n"
    "\nstruct envsh_view{\n"
    "vec4 row_x,row_y,row_z;\n"
    "vec3 right,up;\n"
    "vec2 texel;\n"
    "float depth_range;\n"
    "vec4 spread;\n"
    "uint light,place;\n"
    "};\n"
    "\nstruct envsh_receiver{\n"
    "vec2 at,slope;\n"
    "float z,limit;\n"
    "};\n"
    "\nvec4 envsh_texel(uint light,uint i){return uintBitsToFloat(ENVSH_TEXEL(8u*light+i));}\n"
    "\nvec3 envsh_direction(uint light){return envsh_texel(light,5u).xyz;}\n"
    "vec3 envsh_power(uint light){return envsh_texel(light,6u).xyz;}\n"
    "\nenvsh_view envsh_read_view(uint light)\n"
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
    "\nuint envsh_hash32(uint x)\n"
    "{\n"
    "uint state=x*747796405u+2891336453u;\n"
    "uint word=((state>>((state>>28)+4u))^state)*277803737u;\n"
    "return(word>>22)^word;\n"
    "}\n"
    "\nuint envsh_hash_combine(uint a,uint b){return envsh_hash32(a+0x9e3779b9u*envsh_hash32(b));}\n"
    "\n\nvec2 envsh_turn(float x)\n"
    "{\n"
    "int k=int(x*0.636619772+0.5);\n"
    "float r=((x-float(k)*1.5703125)-float(k)*4.837512969970703125e-4)-float(k)*7.5497899548918822e-8;\n"
    "float z=r*r,s=r+r*z*(-0.1666665494+z*(0.008332178146+z* -0.0001951729898));\n"
    "float c=(1.0-0.5*z)+z*z*(0.04166664687+z*(-0.001388736752+z*2.443845159e-5));\n"
    "vec2 cs=(k&1)!=0?vec2(s,c):vec2(c,s);\n"
    "return vec2(((k+1)&2)!=0? -cs.x:cs.x,(k&2)!=0? -cs.y:cs.y);\n"
    "}\n"
    "\nivec2 envsh_place(vec2 at){return ivec2(floor(clamp(at,vec2(-64.0),vec2(8192.0))));}\n"
    "\nbool envsh_outside(envsh_query q,ivec2 at)\n"
    "{\n"
    "return any(lessThan(at,ivec2(0)))||any(greaterThanEqual(at,ivec2(q.size)));\n"
    "}\n"
    "\n\nbool envsh_lit(envsh_query q,envsh_view v,envsh_receiver r,ivec2 at,out float stored)\n"
    "{\n"
    "stored=1.0;\n"
    "if(envsh_outside(q,at))return true;\n"
    "stored=ENVSH_STORED(v,at);\n"
    "float z=r.z+max(dot(r.slope,vec2(at)+0.5-r.at),-r.limit);\n"
    "return stored>=1.0||z<=stored;\n"
    "}\n"
    "\n\nint envsh_decide_box(envsh_query q,envsh_view v,vec2 at,vec2 reach,float nearest,float farthest)\n"
    "{\n"
    "ivec2 low=envsh_place(at-reach),high=envsh_place(at+reach),last=ivec2(q.size-1);\n"
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
    "if(least>=1.0||farthest<=least)return 1;\n"
    "return!outside&&most<1.0&&nearest>most?0: -1;\n"
    "}\n"
    "\n\nint envsh_decide(envsh_query q,envsh_view v,envsh_receiver r,vec2 reach)\n"
    "{\n"
    "float slope=dot(abs(r.slope),reach+1.0);\n"
    "return envsh_decide_box(q,v,r.at,reach,r.z-min(slope,r.limit),r.z+slope);\n"
    "}\n"
    "\n\nfloat envsh_smooth(envsh_query q,envsh_view v,envsh_receiver r)\n"
    "{\n"
    "int reach=int(q.radius)+1;\n"
    "ivec2 center=envsh_place(r.at);\n"
    "float sum=0.0,weights=0.0,stored;\n"
    "for(int y= -reach;y<=reach;y++)\n"
    "for(int x= -reach;x<=reach;x++){\n"
    "ivec2 at=center+ivec2(x,y);\n"
    "vec2 w=q.radius+1.0-abs(vec2(at)+0.5-r.at);\n"
    "if(!(w.x>0.0)|| !(w.y>0.0))continue;\n"
    "weights+=w.x*w.y;\n"
    "if(envsh_lit(q,v,r,at,stored))sum+=w.x*w.y;\n"
    "}\n"
    "return weights>0.0?sum/weights:1.0;\n"
    "}\n"
    "\n\nivec2 envsh_tap(envsh_receiver r,uint i,vec2 a,vec2 b,vec2 cs)\n"
    "{\n"
    "vec2 d=ENVSH_DISC(i);\n"
    "return envsh_place(r.at+(d.x*cs.x-d.y*cs.y)*a+(d.x*cs.y+d.y*cs.x)*b);\n"
    "}\n"
    "\nfloat envsh_taps(envsh_query q,envsh_view v,envsh_receiver r,vec2 a,vec2 b,vec2 cs)\n"
    "{\n",
    "float lit=0.0,stored;\n"
    "for(uint i=0u;i<q.taps;i++)lit+=envsh_lit(q,v,r,envsh_tap(r,i,a,b,cs),stored)?1.0:0.0;\n"
    "return lit/float(q.taps);\n"
    "}\n"
    "\n\nvoid envsh_limit(inout vec2 a,inout vec2 b,float most)\n"
    "{\n"
    "float la=length(a),lb=length(b),least=min(0.7,most),f;\n"
    "f=la>most?most/la:1.0;\n"
    "a*=f;\n"
    "la*=f;\n"
    "f=lb>most?most/lb:1.0;\n"
    "b*=f;\n"
    "lb*=f;\n"
    "if(la<least){\n"
    "a=vec2(least,0.0);\n"
    "b=vec2(0.0,least);\n"
    "}else if(lb<least){\n"
    "b=vec2(-a.y,a.x)*(least/la);\n"
    "}\n"
    "}\n"
    "\n\n\nvoid envsh_kernel(envsh_query q,envsh_view v,float away,out vec2 a,out vec2 b)\n"
    "{\n"
    "away=min(max(away,0.0)*q.extent_scale,1e9);\n"
    "a=clamp(v.spread.xy*away,-1e15,1e15);\n"
    "b=clamp(v.spread.zw*away,-1e15,1e15);\n"
    "envsh_limit(a,b,q.radius);\n"
    "}\n"
    "\n\nfloat envsh_penumbra(envsh_query q,envsh_view v,envsh_receiver r,vec2 cs)\n"
    "{\n"
    "float blockers=0.0,found=0.0,stored;\n"
    "vec2 a,b;\n"
    "envsh_kernel(q,v,r.z,a,b);\n"
    "int known=envsh_decide(q,v,r,abs(a)+abs(b));\n"
    "if(known>=0)return float(known);\n"
    "for(uint i=0u;i<q.taps;i++)\n"
    "if(!envsh_lit(q,v,r,envsh_tap(r,i,a,b,cs),stored)){\n"
    "blockers+=stored;\n"
    "found+=1.0;\n"
    "}\n"
    "if(found==0.0)return 1.0;\n"
    "envsh_kernel(q,v,r.z-blockers/found,a,b);\n"
    "return envsh_taps(q,v,r,a,b,cs);\n"
    "}\n"
    "\n\nfloat envsh_plane_limit(envsh_query q,envsh_view v)\n"
    "{\n"
    "float texels=ENVSH_FILTER==4?4.0:ENVSH_FILTER==1?3.0:q.radius+(ENVSH_FILTER==2?4.0:3.0);\n"
    "return texels*max(v.texel.x,v.texel.y)/v.depth_range;\n"
    "}\n"
    "\n\nenvsh_receiver envsh_receive(envsh_query q,envsh_view v,vec3 p,vec3 n,float cosine)\n"
    "{\n"
    "envsh_receiver r;\n"
    "vec2 flat_n=vec2(dot(n,v.right),dot(n,v.up));\n"
    "float texel=max(v.texel.x,v.texel.y);\n"
    "p+=n*(q.bias*texel*(0.25+0.75*length(flat_n)));\n"
    "r.at=vec2(dot(v.row_x,vec4(p,1.0)),dot(v.row_y,vec4(p,1.0)));\n"
    "r.z=dot(v.row_z,vec4(p,1.0));\n"
    "r.slope=flat_n*v.texel/(max(cosine,0.1)*v.depth_range);\n"
    "r.limit=envsh_plane_limit(q,v);\n"
    "return r;\n"
    "}\n"
    "\n\nfloat envsh_visible(envsh_query q,uint light,vec3 p,vec3 n,uint index)\n"
    "{\n"
    "float cosine=dot(n,envsh_direction(light)),stored;\n"
    "if(!(cosine>0.0))return 0.0;\n"
    "envsh_view v=envsh_read_view(light);\n"
    "envsh_receiver r=envsh_receive(q,v,p,n,cosine);\n"
    "#if ENVSH_FILTER == 1\n"
    "return envsh_lit(q,v,r,envsh_place(r.at),stored)?1.0:0.0;\n"
    "#elif ENVSH_FILTER == 2\n"
    "int known=envsh_decide(q,v,r,vec2(q.radius+1.0));\n"
    "return known>=0?float(known):envsh_smooth(q,v,r);\n"
    "#else\n"
    "vec2 cs=envsh_turn(6.28318531*(float(envsh_hash_combine(q.seed,index)>>8)*(1.0/16777216.0)));\n"
    "#if ENVSH_FILTER == 3\n"
    "int known=envsh_decide(q,v,r,vec2(q.radius));\n"
    "return known>=0?float(known):envsh_taps(q,v,r,vec2(q.radius,0.0),vec2(0.0,q.radius),cs);\n"
    "#else\n"
    "return envsh_penumbra(q,v,r,cs);\n"
    "#endif\n"
    "#endif\n"
    "}\n"
    "\n\nvec3 envsh_irradiance(envsh_query q,uint from,uint to,vec3 p,vec3 n,vec3 flat_n,uint index)\n"
    "{\n"
    "vec3 sum=vec3(0.0);\n"
    "for(uint light=from;light<to;light++){\n"
    "float cosine=dot(n,envsh_direction(light));\n"
    "if(cosine>0.0)sum+=envsh_visible(q,light,p,flat_n,index)*cosine*envsh_power(light);\n"
    "}\n"
    "return sum;\n"
    "}\n"
};

static const char *const glbk__glsl_prog_envsh_cast_frag[] = {
    "\n\n\n\nin float envsh_depth;\n"
    "#if ENVSH_RGBA\n"
    "layout(location=0)out uvec4 envsh_bits;\n"
    "#endif\n"
    "\nvoid main()\n"
    "{\n"
    "ENVSH_STORE(envsh_depth)\n"
    "}\n"
};

static const char *const glbk__glsl_prog_envsh_cast_vert[] = {
    "\n\n\nlayout(location=0)in vec3 position;\n"
    "out float envsh_depth;\n"
    "\nvoid main()\n"
    "{\n"
    "ENVSH_CAST((glbk_envsh_object.world*vec4(position,1.0)).xyz)\n"
    "}\n"
};

static const char *const glbk__glsl_prog_envsh_cells_frag[] = {
    "\n\n\n\n\nlayout(location=0)out uvec4 result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy);\n"
    "uvec4 job=glbk_envsh_object.lights;\n"
    "vec2 bounds=vec2(1.0,0.0);\n"
    "if(job.x==0u){\n"
    "int cells=int(glbk_envsh_scene.tiles.w),last=int(glbk_envsh_scene.tiles.x)-1;\n"
    "ivec2 tile=at/cells,from=(at-tile*cells)*8;\n"
    "uint place=uint(tile.x)|(uint(tile.y)<<11)|((job.y/job.z)<<22);\n"
    "for(int i=0;i<64;i++){\n"
    "float z=envsh_stored(job.y%job.z,place,min(from+ivec2(i&7,i>>3),ivec2(last)));\n"
    "bounds=vec2(min(bounds.x,z),max(bounds.y,z));\n"
    "}\n"
    "}else{\n"
    "for(int i=0;i<4;i++){\n"
    "ivec3 below=ivec3(2*at+ivec2(i&1,i>>1),int(job.y));\n"
    "vec2 b=uintBitsToFloat(texelFetch(glbk_envsh_cells,below,0).xy);\n"
    "bounds=vec2(min(bounds.x,b.x),max(bounds.y,b.y));\n"
    "}\n"
    "}\n"
    "result=uvec4(floatBitsToUint(bounds),0u,0u);\n"
    "}\n"
};

static const char *const glbk__glsl_prog_envsh_resolve_frag[] = {
    "\n\n\nlayout(location=0)out vec4 result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=glbk_picture_at();\n"
    "glbk_point p;\n"
    "bool seen=glbk_read_point(at,p);\n"
    "glbk_picture_show(seen,p.position);\n"
    "vec3 albedo=seen?p.diffuse*(1.0-p.metallic):vec3(0.0);\n"
    "vec3 sum=glbk_envsh_object.lights.w!=0u?glbk_unpack(texelFetch(glbk_envsh_sum,at,0)).xyz:vec3(0.0);\n"
    "result=vec4(sum*albedo*0.318309886,1.0);\n"
    "}\n"
};

static const char *const glbk__glsl_prog_envsh_shade_comp[] = {
    "\n\n\n\n\nlayout(local_size_x=8,local_size_y=8)in;\n"
    "\nshared uint envsh_all_lit[2],envsh_asked[2];\n"
    "\nstruct envsh_pixel{bool seen;vec3 p,n,flat_n;};\n"
    "\n\nenvsh_group envsh_bounds(envsh_pixel pixel)\n"
    "{\n"
    "uint thread=gl_LocalInvocationIndex;\n"
    "vec3 values[6]=vec3[6](pixel.p,pixel.n,pixel.flat_n,-pixel.p,-pixel.n,-pixel.flat_n);\n"
    "for(uint i=0u;i<6u;i++)\n"
    "envsh_chunk[64u*i+thread]=floatBitsToUint(vec4(pixel.seen?values[i]:vec3(3e38),0.0));\n"
    "for(uint left=32u;left>0u;left>>=1){\n"
    "barrier();\n"
    "for(uint i=thread;thread<left&&i<384u;i+=64u){\n"
    "vec4 a=uintBitsToFloat(envsh_chunk[i]),b=uintBitsToFloat(envsh_chunk[i+left]);\n"
    "envsh_chunk[i]=floatBitsToUint(min(a,b));\n"
    "}\n"
    "}\n"
    "barrier();\n"
    "for(uint i=0u;i<6u;i++)values[i]=uintBitsToFloat(envsh_chunk[64u*i].xyz);\n"
    "return envsh_group(values[0],-values[3],values[1],-values[4],values[2],-values[5]);\n"
    "}\n"
    "\nvoid envsh_sort_lights(envsh_query q,envsh_group g,uint from,uint to)\n"
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
    "\n\nuint envsh_take(inout uvec2 left)\n"
    "{\n"
    "uint half_of=left.x!=0u?0u:1u,bit=uint(findLSB(left[half_of]));\n"
    "left[half_of]&=left[half_of]-1u;\n"
    "return 32u*half_of+bit;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_GlobalInvocationID.xy),size=textureSize(glbk_gbuffer_place,0);\n"
    "uvec4 range=glbk_envsh_query.range;\n"
    "uint index=uint(at.y)*range.z+uint(at.x);\n"
    "bool inside=all(lessThan(at,size));\n"
    "envsh_query q=envsh_bound_query();\n"
    "envsh_pixel pixel;\n"
    "glbk_point point;\n"
    "pixel.seen=glbk_read_point(min(at,size-1),point)&&inside;\n"
    "pixel.p=point.position;\n"
    "pixel.n=pixel.seen?point.normal:vec3(0.0);\n"
    "pixel.flat_n=pixel.seen?point.geometric:vec3(0.0);\n"
    "envsh_group g=envsh_bounds(pixel);\n"
    "uint to=g.low.x<3e38?range.y:range.x;\n"
    "vec3 sum=inside&&range.w!=0u?imageLoad(glbk_envsh_total,at).xyz:vec3(0.0);\n"
    "for(uint from=range.x;from<to;from+=64u){\n"
    "envsh_sort_lights(q,g,from,to);\n"
    "for(uvec2 left=uvec2(envsh_all_lit[0],envsh_all_lit[1]);left!=uvec2(0u);){\n"
    "uint light=from+envsh_take(left);\n"
    "vec3 d=envsh_direction(light);\n"
    "if(dot(pixel.flat_n,d)>0.0)sum+=max(dot(pixel.n,d),0.0)*envsh_power(light);\n"
    "}\n"
    "for(uvec2 left=uvec2(envsh_asked[0],envsh_asked[1]);left!=uvec2(0u);){\n"
    "uint light=from+envsh_take(left);\n"
    "sum+=envsh_irradiance(q,light,light+1u,pixel.p,pixel.n,pixel.flat_n,index);\n"
    "}\n"
    "}\n"
    "if(inside)imageStore(glbk_envsh_total,at,vec4(sum,0.0));\n"
    "}\n"
};

static const char *const glbk__glsl_prog_envsh_shade_frag[] = {
    "\n\n\n\nlayout(location=0)out glbk_color result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy);\n"
    "uvec4 range=glbk_envsh_query.range;\n"
    "vec3 sum=range.w!=0u?glbk_unpack(texelFetch(glbk_envsh_sum,at,0)).xyz:vec3(0.0);\n"
    "glbk_point p;\n"
    "if(glbk_read_point(at,p)){\n"
    "uint index=uint(at.y)*range.z+uint(at.x);\n"
    "sum+=envsh_irradiance(envsh_bound_query(),range.x,range.y,p.position,p.normal,p.geometric,index);\n"
    "}\n"
    "result=glbk_pack(vec4(sum,0.0));\n"
    "}\n"
};

static const glbk_file glbk__envsh_files[] = {
    { "lib/envsh_access.glsl", glbk__glsl_lib_envsh_access_glsl, 1, "table envsh_bindings envsh_scene", "",
      "", "" },
    { "lib/envsh_bindings.glsl", glbk__glsl_lib_envsh_bindings_glsl, 1, "", "",
      "", "" },
    { "lib/envsh_cast.glsl", glbk__glsl_lib_envsh_cast_glsl, 1, "table envsh_bindings envsh_object envsh_scene", "",
      "", "" },
    { "lib/envsh_chunk.glsl", glbk__glsl_lib_envsh_chunk_glsl, 1, "table envsh_bindings", "",
      "", "" },
    { "lib/envsh_disc.glsl", glbk__glsl_lib_envsh_disc_glsl, 1, "envsh_bindings envsh_query", "",
      "", "" },
    { "lib/envsh_group.glsl", glbk__glsl_lib_envsh_group_glsl, 1, "envsh_visible", "",
      "", "" },
    { "lib/envsh_light.glsl", glbk__glsl_lib_envsh_light_glsl, 1, "envsh_access envsh_disc envsh_visible envsh_query envsh_scene", "",
      "", "" },
    { "lib/envsh_object.glsl", glbk__glsl_lib_envsh_object_glsl, 1, "", "",
      "", "glbk_envsh_object" },
    { "lib/envsh_query.glsl", glbk__glsl_lib_envsh_query_glsl, 1, "", "",
      "", "glbk_envsh_query" },
    { "lib/envsh_scene.glsl", glbk__glsl_lib_envsh_scene_glsl, 1, "", "",
      "", "glbk_envsh_scene" },
    { "lib/envsh_visible.glsl", glbk__glsl_lib_envsh_visible_glsl, 2, "", "",
      "", "" },
    { "prog/envsh_cast.frag", glbk__glsl_prog_envsh_cast_frag, 1, "envsh_cast", "envsh_cast.vert",
      "ENVSH_RGBA=0 | ENVSH_RGBA=1", "" },
    { "prog/envsh_cast.vert", glbk__glsl_prog_envsh_cast_vert, 1, "envsh_cast envsh_object", "",
      "ENVSH_RGBA=0 | ENVSH_RGBA=1", "" },
    { "prog/envsh_cells.frag", glbk__glsl_prog_envsh_cells_frag, 1, "envsh_access envsh_object envsh_scene", "screen.vert",
      "ENVSH_RGBA=0 | ENVSH_RGBA=1", "" },
    { "prog/envsh_resolve.frag", glbk__glsl_prog_envsh_resolve_frag, 1, "envsh_bindings gbuffer picture envsh_object", "screen.vert",
      "", "" },
    { "prog/envsh_shade.comp", glbk__glsl_prog_envsh_shade_comp, 1, "envsh_chunk envsh_light envsh_group gbuffer envsh_query", "",
      "ENVSH_FILTER=1 ENVSH_RGBA=0 | ENVSH_FILTER=2 ENVSH_RGBA=1 | ENVSH_FILTER=3 ENVSH_RGBA=0 | ENVSH_FILTER=4 ENVSH_RGBA=1", "" },
    { "prog/envsh_shade.frag", glbk__glsl_prog_envsh_shade_frag, 1, "envsh_light gbuffer envsh_query", "screen.vert",
      "ENVSH_FILTER=1 ENVSH_RGBA=0 | ENVSH_FILTER=2 ENVSH_RGBA=1 | ENVSH_FILTER=3 ENVSH_RGBA=0 | ENVSH_FILTER=4 ENVSH_RGBA=1", "" }
};


/* ==== src/gl_envshadow/part.h ==== */

/* ---- envsh: this header's GLSL, textures and blocks, by which programs find them ---- */

GLBK__PART_CODE(envsh, ENVSH)

/* ==== src/gl_envshadow/maps.h ==== */

/* ---- envsh: shadow maps ---- */

enum { GLBK__ENVSH_RECORD = 8, GLBK__ENVSH_CELL = 8, GLBK__ENVSH_MAX_SIDE = 8192 };

/* As square as may be, then pages. */
static void glbk__envsh_lay_out(const glbk_context *ctx, glbk_envsh_maps *m)
{
    uint32_t side = ctx->max_side < GLBK__ENVSH_MAX_SIDE ? ctx->max_side : (uint32_t)GLBK__ENVSH_MAX_SIDE;
    uint32_t slots = (m->capacity + m->channels - 1) / m->channels, most = side / m->map_side;
    for (side = 1; side < most && side * side < slots;) side++;
    m->across = slots < side ? slots : side;
    m->down = (slots + m->across - 1) / m->across;
    m->down = m->down < most ? m->down : most;
    m->pages = m->down ? (slots + m->across * m->down - 1) / (m->across * m->down) : 0;
    for (m->cells_wide = 1, m->levels = 1; m->cells_wide * GLBK__ENVSH_CELL < m->map_side; m->levels++)
        m->cells_wide *= 2;
}

static glbk_result glbk__envsh_create_textures(glbk_context *ctx, glbk_envsh_maps *m)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result;

    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    texture.format = m->channels == 4 ? GLBK_FORMAT_RGBA32UI : GLBK_FORMAT_DEPTH32F;
    texture.width = m->across * m->map_side;
    texture.height = m->down * m->map_side;
    texture.layers = m->pages;
    result = glbk_texture_create(ctx, &texture, &m->atlas);
    target.depth = &m->atlas;
    if (m->channels == 4 && result == GLBK_OK) {
        texture.format = GLBK_FORMAT_DEPTH32F;
        texture.layers = 0;
        result = glbk_texture_create(ctx, &texture, &m->depth);
        target.color[0] = &m->atlas;
        target.depth = &m->depth;
    }
    if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &m->atlas_target);
    texture.format = GLBK_FORMAT_RG32UI;
    texture.width = m->across * m->cells_wide;
    texture.height = m->down * m->cells_wide;
    texture.layers = m->pages * m->channels;
    texture.levels = m->levels;
    if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &m->cells);
    memset(&target, 0, sizeof target);
    target.color[0] = &m->cells;
    if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &m->cell_target);
    if (result == GLBK_OK)
        result =
            glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, GLBK__ENVSH_RECORD * (size_t)m->capacity, &m->views);
    return result;
}

static glbk_result glbk__envsh_create_programs(glbk_context *ctx, const glbk_envsh_maps_desc *d, glbk_envsh_maps *m)
{
    const char *defines = m->channels == 4 ? "ENVSH_RGBA=1" : "ENVSH_RGBA=0";
    glbk_result result;
    if (d->vertex) {
        glbk_source source;
        memset(&source, 0, sizeof source);
        source.parts[0] = glbk_envsh_part();
        source.vertex = d->vertex;
        source.fragment = d->fragment;
        source.uses = "envsh_cast";
        source.defines = defines;
        result = glbk_program_compile(ctx, &source, &m->cast);
    } else {
        result = glbk_program_create(ctx, glbk_envsh_part(), "envsh_cast.frag", defines, &m->cast);
    }
    if (result == GLBK_OK)
        result = glbk_program_create(ctx, glbk_envsh_part(), "envsh_cells.frag", defines, &m->make_cells);
    return result;
}

GLBK_DEF glbk_result glbk_envsh_maps_create(glbk_context *ctx, const glbk_envsh_maps_desc *d, glbk_envsh_maps *out)
{
    glbk_result result;
    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!d) return glbk__bad(ctx, GLBK_ERR_ARGUMENT, __func__, "desc", "is NULL");
    if (!d->capacity || d->capacity > ENVSH_MAX_LIGHTS)
        return glbk__bad_range(ctx, GLBK_ERR_DESC, __func__, "desc.capacity", d->capacity, 1, ENVSH_MAX_LIGHTS);
    if ((d->vertex != NULL) != (d->fragment != NULL))
        return glbk__bad(ctx, GLBK_ERR_DESC, __func__, "desc", "has one of vertex and fragment");
    out->capacity = d->capacity;
    out->map_side = d->map_side ? d->map_side : 256;
    out->guard = d->guard ? d->guard : 4;
    out->channels = d->rgba ? 4 : 1;
    if (out->map_side < 16 || out->map_side > 4096)
        result = glbk__bad_range(ctx, GLBK_ERR_DESC, __func__, "desc.map_side", out->map_side, 16, 4096);
    else if (out->guard > out->map_side / 4)
        result = glbk__bad_range(ctx, GLBK_ERR_DESC, __func__, "desc.guard", out->guard, 1, out->map_side / 4);
    else {
        glbk__envsh_lay_out(ctx, out);
        result = out->pages && out->pages <= 1024 ? glbk__envsh_create_textures(ctx, out) : GLBK_ERR_LIMIT;
    }
    if (result == GLBK_OK) result = glbk__envsh_create_programs(ctx, d, out);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_scene), NULL, &out->scene);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_query), NULL, &out->query);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_object), NULL, &out->object);
    if (result == GLBK_OK) return GLBK_OK;
    glbk_envsh_maps_free(ctx, out);
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

/* Whether the first view was made for tiles of this size: clip space is 2 / map_side of texels. A view of zeros says
   nothing. */
static int glbk__envsh_views_fit(const glbk_envsh_maps *m, const envsh_view *view)
{
    const float *lookup = view->lookup;
    int c, best = 0;
    for (c = 1; c < 3; c++)
        if (fabsf(lookup[c]) > fabsf(lookup[best])) best = c;
    return fabsf(view->clip[4 * best] * (float)m->map_side - 2 * lookup[best]) <= 1e-3f * fabsf(lookup[best]);
}

/* A light's eight texels. */
static void glbk__envsh_record(const glbk_envsh_maps *m, const envsh_view *v, uint32_t light, uint32_t *words)
{
    uint32_t slot = light / m->channels, place;
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

static glbk_result glbk__envsh_upload(glbk_context *ctx, glbk_envsh_maps *m, const envsh_view *views,
                                      uint32_t count)
{
    glbk_envsh__allocator memory = glbk_envsh__memory(ctx);
    uint32_t *words = (uint32_t *)glbk_envsh__alloc_array(&memory, (size_t)count + 1, 4 * 4 * GLBK__ENVSH_RECORD), i;
    glbk_envsh_scene scene;
    glbk_result result = GLBK_OK;

    if (!words) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i++) glbk__envsh_record(m, &views[i], i, words + 4 * GLBK__ENVSH_RECORD * (size_t)i);
    if (count) result = glbk_table_update(ctx, &m->views, 0, GLBK__ENVSH_RECORD * (size_t)count, words);
    glbk_envsh__free(&memory, words);
    if (result != GLBK_OK) return result;
    memset(&scene, 0, sizeof scene);
    scene.tiles[0] = m->map_side;
    scene.tiles[1] = m->guard;
    scene.tiles[2] = m->channels;
    scene.tiles[3] = m->cells_wide;
    scene.range[0] = m->count = count;
    scene.range[1] = m->levels;
    scene.page[0] = 2.0f / (float)(m->across * m->map_side);
    scene.page[1] = 2.0f / (float)(m->down * m->map_side);
    scene.page[2] = 2.0f / (float)(m->map_side - 2 * m->guard);
    return glbk_buffer_update(ctx, &m->scene, 0, sizeof scene, &scene);
}

GLBK_DEF glbk_result glbk_envsh_cast(glbk_context *ctx, glbk_envsh_maps *m, const float world[16])
{
    glbk_envsh_object object;
    int i;
    if (!ctx || !m || !m->object.name) return GLBK_ERR_ARGUMENT;
    memset(&object, 0, sizeof object);
    if (world) memcpy(object.world, world, sizeof object.world);
    else
        for (i = 0; i < 4; i++) object.world[5 * i] = 1.0f;
    object.lights[0] = m->first;
    object.lights[1] = m->step;
    m->casts++;
    return glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_object, &m->object, &object);
}

/* Clip distances 0 to 3, and depth clamped: on OpenGL, while casting. */
static void glbk__envsh_clip(const glbk_context *ctx, int on)
{
    uint32_t i;
    for (i = 0; !ctx->es && i < 4; i++) glbk__set_cap(ctx, 0x3000 + i, on);
    if (!ctx->es) glbk__set_cap(ctx, 0x864F, on);
}

/* One call of draw: lights first, first + step, ... of a page, a channel and, on ES, a column of tiles. */
static glbk_result glbk__envsh_cast_round(glbk_context *ctx, glbk_envsh_maps *m, uint32_t page, uint32_t channel,
                                          uint32_t column, glbk_envsh_draw_fn draw_fn, void *user)
{
    static const uint32_t far_bits[4] = { 0x3f800000, 0x3f800000, 0x3f800000, 0x3f800000 };
    uint32_t tiles = m->across * m->down, first = (page * tiles + column) * m->channels + channel, i;
    uint32_t step = (ctx->es ? m->across : 1) * m->channels, end = (page + 1) * tiles * m->channels;
    glbk_pass pass;
    glbk_result result;

    end = end < m->count ? end : m->count;
    memset(&pass, 0, sizeof pass);
    pass.target = &m->atlas_target;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_begin(ctx, &pass, &m->cast);
    if (result != GLBK_OK) return result;
    i = m->channels == 4;
    glbk__attach(ctx, i ? GLBK_GL_COLOR_ATTACHMENT0 : (uint32_t)GLBK_GL_DEPTH_ATTACHMENT, &m->atlas, 0, page);
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
    m->first = first;
    m->step = step;
    m->casts = 0;
    result = draw_fn(user, ctx, m, (end - first + step - 1) / step);
    if (!ctx->lost) glbk__envsh_clip(ctx, 0);
    if (ctx->check && result == GLBK_OK && !m->casts)
        return glbk__bad(ctx, GLBK_ERR_ORDER, "glbk_envsh_maps_render", "draw_fn", "never called glbk_envsh_cast");
    return result;
}

/* The levels of cells of one layer. Each reads the one below, which is made the texture's only one meanwhile. */
static glbk_result glbk__envsh_cell_layer(glbk_context *ctx, glbk_envsh_maps *m, uint32_t layer)
{
    glbk_envsh_object object;
    glbk_pass pass;
    glbk_result result = GLBK_OK;
    uint32_t level;

    memset(&object, 0, sizeof object);
    memset(&pass, 0, sizeof pass);
    pass.target = &m->cell_target;
    object.lights[1] = layer;
    object.lights[2] = m->channels;
    for (level = 0; level < m->levels && result == GLBK_OK; level++) {
        const int32_t below = level ? (int32_t)level - 1 : 0;     /* never the level that is drawn to */
        object.lights[0] = level;
        pass.viewport[2] = (int32_t)(m->cells.width >> level);
        pass.viewport[3] = (int32_t)(m->cells.height >> level);
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_object, &m->object, &object);
        if (result == GLBK_OK) result = glbk_begin(ctx, &pass, &m->make_cells);
        if (result != GLBK_OK) break;
        glbk__attach(ctx, GLBK_GL_COLOR_ATTACHMENT0, &m->cells, level, layer);
        glbk_bind_texture(ctx, m->channels == 4 ? GLBK_SLOT_glbk_envsh_depth4 : GLBK_SLOT_glbk_envsh_depth, &m->atlas);
        glbk_bind_block(ctx, GLBK_SLOT_glbk_envsh_scene, &m->scene);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_cells, &m->cells);
        ctx->gl.TexParameteri(m->cells.gl_target, 0x813C /* BASE_LEVEL */, below);
        ctx->gl.TexParameteri(m->cells.gl_target, 0x813D /* MAX_LEVEL */, below);
        if (!level) glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_cells, NULL);      /* reads none */
        glbk_draw_screen(ctx);
    }
    if (ctx->lost) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_cells, &m->cells);
    ctx->gl.TexParameteri(m->cells.gl_target, 0x813C, 0);
    ctx->gl.TexParameteri(m->cells.gl_target, 0x813D, (int32_t)m->levels - 1);
    return result;
}

/* Whether draw_fn drew all instances, after glbk__envsh_cell_layer, which has left the uppermost level of the layer in
   cell_target: a cell a tile. All views hold all casters, so where those of the first instance have something in them,
   not all others can be empty. */
static glbk_result glbk__envsh_check_instances(glbk_context *ctx, glbk_envsh_maps *m, uint32_t layer)
{
    const uint32_t tiles = m->across * m->down, base = layer / m->channels * tiles;
    const uint32_t slots = (m->count - layer % m->channels + m->channels - 1) / m->channels;
    const uint32_t count = slots < base + tiles ? slots - base : tiles, firsts = ctx->es ? m->across : 1;
    const uint32_t far_bits = 0x3f800000;
    glbk_envsh__allocator memory = glbk_envsh__memory(ctx);
    uint32_t *cells, i, drawn = 0, others = 0;
    glbk_result result;
    if (slots <= base || count <= firsts) return GLBK_OK;
    cells = (uint32_t *)glbk_envsh__alloc_array(&memory, tiles, 16);
    if (!cells) return GLBK_ERR_ALLOC;
    result = glbk_target_read(ctx, &m->cell_target, 0, 0, 0, m->across, m->down, cells);
    for (i = 0; i < count && result == GLBK_OK; i++)
        if (cells[4 * i] < far_bits) *(i < firsts ? &drawn : &others) += 1;
    glbk_envsh__free(&memory, cells);
    if (drawn && !others && result == GLBK_OK)
        return glbk__bad(ctx, GLBK_ERR_ORDER, "glbk_envsh_maps_render", "draw_fn", "drew one instance, not all");
    return result;
}

GLBK_DEF glbk_result glbk_envsh_maps_render(glbk_context *ctx, glbk_envsh_maps *m, const envsh_view *views,
                                            uint32_t count, glbk_envsh_draw_fn draw_fn, void *user)
{
    uint32_t pages, page, channel, column, layer;
    glbk_result result;

    if (!ctx || !m || !m->views.name || (count && !views) || !draw_fn)
        return glbk__bad(ctx, GLBK_ERR_ARGUMENT, __func__, "maps, views or draw_fn", "is NULL or was not created");
    if (count > m->capacity)
        return glbk__bad_range(ctx, GLBK_ERR_ARGUMENT, __func__, "count", count, 0, m->capacity);
    if (count && !glbk__envsh_views_fit(m, views))
        return glbk__bad_value(ctx, GLBK_ERR_MISMATCH, __func__, "desc.map_side", m->map_side,
                               "the map_side of the envsh_maps_desc that made the views");
    if (count && views->guard && views->guard != m->guard)
        return glbk__bad_value(ctx, GLBK_ERR_MISMATCH, __func__, "desc.guard", m->guard,
                               "the guard of the envsh_maps_desc that made the views");
    m->count = 0;
    result = glbk__envsh_upload(ctx, m, views, count);
    pages = (count + m->across * m->down * m->channels - 1) / (m->across * m->down * m->channels);
    for (page = 0; page < pages; page++)
        for (channel = 0; channel < m->channels; channel++)
            for (column = 0; column < (ctx->es ? m->across : 1) && result == GLBK_OK; column++)
                result = glbk__envsh_cast_round(ctx, m, page, channel, column, draw_fn, user);
    for (layer = 0; layer < pages * m->channels && result == GLBK_OK; layer++) {
        result = glbk__envsh_cell_layer(ctx, m, layer);
        if (ctx->check && result == GLBK_OK) result = glbk__envsh_check_instances(ctx, m, layer);
    }
    if (result != GLBK_OK) m->count = 0;
    return result;
}

/* ==== src/gl_envshadow/queries.h ==== */

/* ---- envsh: queries ---- */

/* The ranges and defaults of envsh_query. */
static float glbk__envsh_or_default(float value, float standard)
{
    return value < 0 ? 0.0f : value == 0 ? standard : value;
}

static glbk_result glbk__envsh_query_of(const glbk_context *ctx, const char *function, const envsh_query *from,
                                        envsh_query *q)
{
    static const float most[] = { 0, 0, 8, 32, 64 };
    memset(q, 0, sizeof *q);
    if (from) *q = *from;
    if ((unsigned)q->filter >= ENVSH_FILTER_COUNT)
        return glbk__bad_range(ctx, GLBK_ERR_DESC, function, "query.filter", q->filter, 0, ENVSH_FILTER_COUNT - 1);
    if (q->filter == ENVSH_FILTER_DEFAULT) q->filter = ENVSH_FILTER_PENUMBRA;
    if (!(q->bias <= 1e6f))
        return glbk__bad_value(ctx, GLBK_ERR_DESC, function, "query.bias", (double)q->bias, "at most 1e6 texels");
    q->bias = glbk__envsh_or_default(q->bias, 1);
    if (!q->taps) q->taps = 16;
    if (q->filter == ENVSH_FILTER_PLAIN) {
        q->taps = 1;
        q->radius = q->extent_scale = 0;
        return GLBK_OK;
    }
    if (!(q->radius <= most[q->filter]) || (q->filter == ENVSH_FILTER_SMOOTH && q->radius < 0.5f && q->radius != 0))
        return glbk__bad_range(ctx, GLBK_ERR_DESC, function, "query.radius", (double)q->radius,
                               q->filter == ENVSH_FILTER_SMOOTH ? 0.5 : 0, (double)most[q->filter]);
    q->radius = glbk__envsh_or_default(q->radius, q->filter == ENVSH_FILTER_PENUMBRA ? 12.0f : 2.0f);
    if (q->filter == ENVSH_FILTER_SMOOTH) return GLBK_OK;
    if (q->taps > ENVSH_MAX_TAPS)
        return glbk__bad_range(ctx, GLBK_ERR_DESC, function, "query.taps", q->taps, 0, ENVSH_MAX_TAPS);
    if (!(q->extent_scale <= 1e6f))
        return glbk__bad_value(ctx, GLBK_ERR_DESC, function, "query.extent_scale", (double)q->extent_scale,
                               "at most 1e6");
    q->extent_scale = glbk__envsh_or_default(q->extent_scale, 1);
    return GLBK_OK;
}

/* Vogel's spiral, turned by the golden angle from tap to tap. */
static void glbk__envsh_fill_query(const envsh_query *q, glbk_envsh_query *out)
{
    const double cosine = -0.73736887807831990, sine = 0.67549029426152364;
    double x = 1, y = 0, t;
    uint32_t i;
    memset(out, 0, sizeof *out);
    out->values[0] = q->radius;
    out->values[1] = q->bias;
    out->values[2] = q->extent_scale;
    out->numbers[0] = q->taps;
    out->numbers[1] = q->seed;
    for (i = 0; i < q->taps && i < ENVSH_MAX_TAPS; i++) {
        float radius = sqrtf(((float)i + 0.5f) / (float)q->taps);
        out->disc[2 * i] = radius * (float)x;
        out->disc[2 * i + 1] = radius * (float)y;
        t = x * cosine - y * sine;
        y = x * sine + y * cosine;
        x = t;
    }
}

static void glbk__envsh_bind_all(glbk_context *ctx, const glbk_envsh_maps *m, const glbk_offset *offset)
{
    const glbk_offset at = glbk__offset(offset);
    glbk_bind_texture(ctx, at.unit + (m->channels == 4 ? GLBK_SLOT_glbk_envsh_depth4 : GLBK_SLOT_glbk_envsh_depth),
                      &m->atlas);
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
    glbk_result result;
    if (!ctx || !m || !m->query.name)
        return glbk__bad(ctx, GLBK_ERR_ARGUMENT, __func__, "maps", "is NULL or was not created");
    result = glbk__envsh_query_of(ctx, __func__, query, &q);
    if (result != GLBK_OK) return result;
    glbk__envsh_fill_query(&q, &values);
    result = glbk__put_block(ctx, glbk__offset(offset).block + GLBK_SLOT_glbk_envsh_query, &m->query, &values);
    if (result == GLBK_OK) glbk__envsh_bind_all(ctx, m, offset);
    return result;
}

/* ==== src/gl_envshadow/renderer.h ==== */

/* ---- envsh: the renderer ---- */

GLBK_DEF glbk_result glbk_envsh_renderer_create(glbk_context *ctx, uint32_t width, uint32_t height,
                                                glbk_envsh_renderer *out)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result = GLBK_OK;
    int i;

    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    texture.width = out->width = width;
    texture.height = out->height = height;
    texture.format = GLBK_FORMAT_COLOR;
    out->compute = ctx->compute;
    for (i = 0; i < (out->compute ? 1 : 2) && result == GLBK_OK; i++) {
        memset(&target, 0, sizeof target);
        result = glbk_texture_create(ctx, &texture, &out->sums[i]);
        target.color[0] = &out->sums[i];
        if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &out->targets[i]);
    }
    if (result == GLBK_OK)
        result = glbk__gbuffer_program(ctx, glbk_envsh_part(), "envsh_resolve.frag", NULL, &out->resolve);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_object), NULL, &out->object);
    if (result != GLBK_OK) glbk_envsh_renderer_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_envsh_renderer_free(glbk_context *ctx, glbk_envsh_renderer *r)
{
    uint32_t i;
    if (!r) return;
    for (i = 0; i < 2 * ENVSH_FILTER_COUNT; i++) glbk_program_free(ctx, &r->shade[i]);
    glbk_program_free(ctx, &r->resolve);
    for (i = 0; i < 2; i++) {
        glbk_target_free(ctx, &r->targets[i]);
        glbk_texture_free(ctx, &r->sums[i]);
    }
    glbk_buffer_free(ctx, &r->object);
    memset(r, 0, sizeof *r);
}

/* Whether a G-buffer is there, and of the renderer's size. */
static glbk_result glbk__envsh_fits(const glbk_context *ctx, const char *function, const glbk_envsh_renderer *r,
                                    const glbk_gbuffer *g)
{
    if (!ctx || !r || !r->targets[0].name || !g || !g->colors.name)
        return glbk__bad(ctx, GLBK_ERR_ARGUMENT, function, "renderer or gbuffer", "is NULL or was not created");
    if (r->width == g->width && r->height == g->height) return GLBK_OK;
    return glbk__bad(ctx, GLBK_ERR_MISMATCH, function, "gbuffer", "is of another size than the renderer");
}

static glbk_result glbk__envsh_shade_program(glbk_context *ctx, glbk_envsh_renderer *r, uint32_t filter, uint32_t rgba,
                                             glbk_program **out)
{
    char defines[] = "ENVSH_FILTER=0 ENVSH_RGBA=0";
    *out = &r->shade[2 * filter + rgba];
    if ((*out)->name) return GLBK_OK;
    defines[13] = (char)('0' + filter);
    defines[26] = (char)('0' + rgba);
    return glbk__gbuffer_program(ctx, glbk_envsh_part(), r->compute ? "envsh_shade.comp" : "envsh_shade.frag", defines,
                                 *out);
}

/* The lights of m->query's range. */
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

/* The light of all maps by a query without defaults. */
static glbk_result glbk__envsh_shade_all(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_gbuffer *g,
                                         glbk_envsh_maps *m, const envsh_query *q, uint32_t lights_per_pass)
{
    glbk_envsh_query values;
    glbk_program *program;
    glbk_result result = glbk__envsh_shade_program(ctx, r, (uint32_t)q->filter, m->channels == 4, &program);
    uint32_t from = 0;

    if (result != GLBK_OK) return result;
    if (!q->add) r->begun = 0;
    if (!lights_per_pass) lights_per_pass = ENVSH_MAX_LIGHTS;
    glbk__envsh_fill_query(q, &values);
    for (; from < m->count && result == GLBK_OK; from = values.range[1]) {
        values.range[0] = from;
        values.range[1] = m->count - from < lights_per_pass ? m->count : from + lights_per_pass;
        values.range[2] = r->width;
        values.range[3] = r->begun != 0;
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
    if (result == GLBK_OK && (!m || !m->query.name))
        result = glbk__bad(ctx, GLBK_ERR_ARGUMENT, __func__, "maps", "is NULL or was not created");
    if (result == GLBK_OK) result = glbk__envsh_query_of(ctx, __func__, query, &q);
    return result == GLBK_OK ? glbk__envsh_shade_all(ctx, r, g, m, &q, lights_per_pass) : result;
}

GLBK_DEF glbk_result glbk_envsh_illuminate(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_gbuffer *g,
                                           glbk_envsh_maps *m, const glbk_envsh_frame *f)
{
    envsh_query q;
    uint32_t first = 0, n;
    glbk_result result = glbk__envsh_fits(ctx, __func__, r, g);
    if (result == GLBK_OK && (!m || !m->capacity || !f || (!f->views && f->view_count) || !f->draw_fn))
        result = glbk__bad(ctx, GLBK_ERR_ARGUMENT, __func__, "maps, frame, frame.views or frame.draw_fn",
                           "is NULL or was not created");
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

    if (result != GLBK_OK) return result;
    if (!pass) return glbk__bad(ctx, GLBK_ERR_ARGUMENT, __func__, "pass", "is NULL");
    memset(&object, 0, sizeof object);
    object.lights[3] = r->begun != 0;
    result = glbk__begin_picture(ctx, pass, picture, r->width, r->height, &r->resolve);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_object, &r->object, &object);
    if (result != GLBK_OK) return result;
    (void)glbk_gbuffer_bind(ctx, g, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_sum, &r->sums[r->now]);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_envsh_read(glbk_context *ctx, glbk_envsh_renderer *r, float *rgba)
{
    if (!ctx || !r || !r->targets[0].name || !rgba) return GLBK_ERR_ARGUMENT;
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
