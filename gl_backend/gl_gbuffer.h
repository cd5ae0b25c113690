/* gl_gbuffer.h - v0.9.0 - one G-buffer for all techniques on OpenGL 3.3, ES 3.0 and WebGL 2 - MIT-0 OR Unlicense

   What it does

   Holds what a camera sees: places, normals, materials, entities, for each pixel. gl_csm.h, gl_shadowfield.h,
   gl_envshadow.h, gl_rsm.h and gl_ism.h light it. It is drawn from your vertex arrays,
   whatever the locations of their attributes; or uploaded; or made by one pass from textures that your
   renderer has anyway (glbk_gbuffer_import): depth or places, normals in four packings, colours, gloss,
   entities. Shaders of your own read it by glbk_read_point() of lib/gbuffer.glsl.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, programs, textures and targets, and whose
     conventions, errors and rules about GL's state hold here. Kinds of materials are those of lightsampling.h, whose
     implementation it does not need.
   - One sample and one surface a pixel: no transparency, no multisampling.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #include "gl_backend/gl_gbuffer.h"
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
           glbk_context gl;
           glbk_gbuffer seen;
           glbk_desc desc;
           glbk_gbuffer_desc sizes;
           glbk_import mine;
           glbk_texture depth, normals;
           glbk_result result;

           memset(&desc, 0, sizeof desc);
           memset(&sizes, 0, sizeof sizes);
           memset(&mine, 0, sizeof mine);
           memset(&depth, 0, sizeof depth);
           memset(&normals, 0, sizeof normals);
           desc.get_proc_fn = get_proc;                     // a context is current
           result = glbk_init(&gl, &desc);
           if (result != GLBK_OK) {
               printf("no GL: %s\n", glbk_result_text(result));
               return result != GLBK_ERR_FUNCTION;
           }
           sizes.width = depth.width = normals.width = 640;
           sizes.height = depth.height = normals.height = 360;
           result = glbk_gbuffer_create(&gl, &sizes, &seen);
           depth.name = 1;                                  // of your renderer: what glGenTextures gave it
           normals.name = 2;
           mine.depth = &depth;                             // with the matrix by which it was drawn
           mine.normals = &normals;
           mine.normal_packing = GLBK_NORMAL_PACKING_UNIT;  // RGBA8: 0..1 for -1..1
           mine.world_to_clip[0] = mine.world_to_clip[5] = mine.world_to_clip[10] = mine.world_to_clip[15] = 1;
           mine.material.diffuse[0] = mine.material.diffuse[1] = mine.material.diffuse[2] = 0.5f;
           if (result == GLBK_OK) result = glbk_gbuffer_import(&gl, &seen, &mine);
           printf("%s\n", glbk_result_text(result));
           glbk_gbuffer_free(&gl, &seen);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   Configuration

     GL_GBUFFER_IMPLEMENTATION   in one source file: compiles the code; another file may have gl_backend.h's

   Layouts: docs/gpu-layouts.md.   How to bring your own: docs/gbuffer.md.   State: docs/gl-state.md.
   Licence: end of file. */
/* Not inside the guard: their implementations may be wanted at the second time. lightsampling.h lies above this
   folder. */
#include "gl_backend.h"
#include "../lightsampling.h"

#ifndef GL_GBUFFER_H
#define GL_GBUFFER_H

#if GLBK_VERSION != 900
#error "gl_gbuffer.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_GBUFFER_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_GBUFFER_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/gl_gbuffer/api.h ==== */

/* ---- gbuffer: what a camera sees, for all techniques ----

   Once glbk_gbuffer_create. A frame, by one of three ways; then the passes of the techniques, which are given the
   G-buffer:

       glbk_gbuffer_begin(gl, &seen, world_to_clip, eye);           // draw: for each object glbk_gbuffer_object, and
       glbk_gbuffer_object(gl, &seen, &surface);                    // your vertex array and your draw
       glbk_gbuffer_import(gl, &seen, &mine);                       // or: textures of your own, by one pass
       glbk_gbuffer_upload(gl, &seen, row, rows, pixels);           // or: from the CPU

   For shaders of your own, lib/gbuffer.glsl with glbk_gbuffer_bind:

       bool glbk_read_point(ivec2 at, out glbk_point p);            // false: nothing is seen there

   docs/gpu-layouts.md has the four textures. */

#define GLBK_GBUFFER_TEXTURES(X)                                                                    \
    X(usampler2D, glbk_gbuffer_place, 8)        /* what is read; these are in nobody else's way */  \
    X(usampler2D, glbk_gbuffer_normal, 9)                                                           \
    X(usampler2D, glbk_gbuffer_color, 10)                                                           \
    X(usampler2D, glbk_gbuffer_gloss, 11)                                                           \
    X(sampler2D, glbk_gbuffer_color_map, 0)     /* what is drawn or imported */                     \
    X(sampler2D, glbk_gbuffer_gloss_map, 1)                                                         \
    X(sampler2D, glbk_gbuffer_normal_map, 2)                                                        \
    X(sampler2D, glbk_gbuffer_place_in, 2)      /* what is imported */                              \
    X(sampler2D, glbk_gbuffer_depth_in, 3)                                                          \
    X(sampler2D, glbk_gbuffer_normal_in, 4)                                                         \
    X(sampler2D, glbk_gbuffer_flat_in, 5)                                                           \
    X(sampler2D, glbk_gbuffer_open_in, 6)                                                           \
    X(usampler2D, glbk_gbuffer_entity_in, 7)

#define GLBK_GBUFFER_DRAWN_MEMBERS(X)                                                               \
    X(mat4, world, 1)                                                                               \
    X(mat4, clip, 1)                                                                                \
    X(uvec4, numbers, 1)        /* kind, entity, plane, which maps */                               \
    X(uvec4, lobes, 1)                                                                              \
    X(vec4, diffuse, 1)                                                                             \
    X(vec4, gloss, 1)                                                                               \
    X(vec4, eye, 1)                                                                                 \
    X(vec4, values, 1)          /* texels of less alpha are holes; occlusion */

#define GLBK_GBUFFER_IMPORTED_MEMBERS(X)                                                            \
    X(mat4, from_clip, 1)                                                                           \
    X(mat4, to_clip, 1)                                                                             \
    X(mat4, to_world, 1)                                                                            \
    X(uvec4, numbers, 1)        /* kind, entity, plane */                                           \
    X(uvec4, lobes, 1)                                                                              \
    X(uvec4, how, 1)            /* which textures; packing; width, height */                        \
    X(vec4, diffuse, 1)                                                                             \
    X(vec4, gloss, 1)                                                                               \
    X(vec4, eye, 1)                                                                                 \
    X(vec4, depths, 1)          /* from depths to clip z: scale, offset; occlusion */

#define GLBK_GBUFFER_BLOCKS(X)                                  \
    X(glbk_gbuffer_drawn, 0, GLBK_GBUFFER_DRAWN_MEMBERS)        \
    X(glbk_gbuffer_imported, 0, GLBK_GBUFFER_IMPORTED_MEMBERS)

#define GLBK_GBUFFER_STORAGE(X)
#define GLBK_GBUFFER_IMAGES(X)

GLBK__PART(GBUFFER)

GLBK_DEF const glbk_part *glbk_gbuffer_part(void);
/* The GLSL of this header, for programs of your own that use its library files: glbk_source.parts. */

typedef struct glbk_attributes {    /* locations of a mesh's attributes, 0..15; below 0: it has no such attribute.
                                       All four 0 = 0, 1, 2, 3 */
    int32_t position, normal;       /* without normals: those of the triangles */
    int32_t uv, tangent;            /* tangent: w is the handedness, as in glTF */
} glbk_attributes;

typedef struct glbk_gbuffer_desc {
    uint32_t            width, height;      /* pixels, 1 .. what the context allows */
    glbk_attributes     attributes;         /* of what is drawn into it */
    const glbk_texture *depth;              /* yours, of the same size and a depth format, which must outlive it; NULL =
                                               one of its own, DEPTH32F */
} glbk_gbuffer_desc;                        /* zero it, then set what you care about */

typedef struct glbk_gbuffer {       /* read only; zeroed = none */
    uint32_t        width, height;
    glbk_texture    words[4];       /* place and entity; normal and numbers; colour and geometric normal; gloss */
    glbk_texture    depth;          /* that was drawn with, or yours; see has_depth */
    glbk_target     target, colors; /* with and without the depth */
    glbk_attributes attributes;     /* defaults resolved */
    int             own_depth;      /* private */
    int             has_depth;      /* depth holds that of this frame: 0..1, the smaller the nearer */
    int             has_clip;       /* clip and eye are those of this frame */
    float           clip[16];       /* world to clip space, in OpenGL's convention */
    float           eye[3];
    glbk_program    draw, take;     /* private, as what follows: compiled when they are first used */
    glbk_buffer     drawn, imported;
} glbk_gbuffer;

GLBK_DEF glbk_result glbk_gbuffer_create(glbk_context *ctx, const glbk_gbuffer_desc *desc, glbk_gbuffer *out);
/* Nothing is seen in it. Memory on the GPU: 64 bytes a pixel, and 4 for the depth.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC: a size of 0, a location above 15 or twice, no position; GLBK_ERR_MISMATCH:
            a depth of another size; GLBK_ERR_LIMIT, GLBK_ERR_ALLOC; those of textures and targets */
GLBK_DEF void glbk_gbuffer_free(glbk_context *ctx, glbk_gbuffer *gbuffer);

/* ---- gbuffer: drawing ---- */

typedef struct glbk_surface {       /* an object; all zero: black, Lambert, on no entity */
    float          world[16];       /* object to world; all zero = identity */
    lsamp_material material;        /* diffuse, specular, ... are factors of the maps'; lobes is not looked at: */
    uint32_t       first_lobe;      /* Lafortune: the first of material.lobe_count in the table that the technique was
                                       given (glbk_csm_lights_desc.lobes) */
    uint32_t       entity;          /* counted from 1, in the order in which the technique has them; 0 = none */
    uint32_t       plane;           /* receiver plane (csm) that it lies on, counted from 1, at most 255; 0 = none */
    float          occlusion;       /* of bounced light: 0 open .. 1 none of it comes */
    float          alpha;           /* opacity, a factor of the colour map's; 0 = 1 */
    float          alpha_cutoff;    /* what is less opaque is a hole; 0 = none */
    const glbk_texture *color_map;  /* or NULL, like the others: factors of diffuse, and alpha */
    const glbk_texture *gloss_map;  /* factors of specular; metal-rough: roughness in g, metallic in b, as in glTF */
    const glbk_texture *normal_map; /* tangent space; needs tangents */
} glbk_surface;

GLBK_DEF glbk_result glbk_gbuffer_begin(glbk_context *ctx, glbk_gbuffer *gbuffer, const float world_to_clip[16],
                                        const float eye[3]);
/* Clears the G-buffer and its depth, your own one too, and binds it with its program, which is compiled at first use.
   world_to_clip   OpenGL's clip space, -1..1: a pass sets it so (glbk_begin)
   eye             world; all surfaces are turned to it
   Errors          GLBK_ERR_ARGUMENT; those of glbk_program_create at first use */
GLBK_DEF glbk_result glbk_gbuffer_object(glbk_context *ctx, glbk_gbuffer *gbuffer, const glbk_surface *surface);
/* After glbk_gbuffer_begin, once or often: then bind your vertex array and draw. Attributes of desc.attributes that the
   array has not enabled must have been set to zero.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, a field out of range; GLBK_ERR_ORDER, before glbk_gbuffer_begin */

/* ---- gbuffer: from the CPU ---- */

typedef struct glbk_pixel {
    float          position[3];     /* world */
    float          normal[3];       /* unit, for shading, on the side that is seen; 0 0 0: nothing is seen here */
    float          geometric[3];    /* unit, the surface's own; 0 0 0 = normal */
    float          tangent[3];      /* unit, for Lafortune's lobes; 0 0 0 = any */
    lsamp_material material;        /* lobes is not looked at: */
    uint32_t       first_lobe;      /* this, and the rest, as in glbk_surface */
    uint32_t       entity, plane;
    float          occlusion;
} glbk_pixel;

GLBK_DEF glbk_result glbk_gbuffer_upload(glbk_context *ctx, glbk_gbuffer *gbuffer, uint32_t row, uint32_t rows,
                                         const glbk_pixel *pixels);
/* Whole rows. Row 0 comes back first where a technique reads its light; for a picture on the screen it is the lowest.
   There is no depth of it: has_depth and has_clip are 0 afterwards.
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC */

/* ---- gbuffer: from textures of your own ---- */

typedef enum glbk_normal_packing {
    GLBK_NORMAL_PACKING_DEFAULT,            /* = GLBK_NORMAL_PACKING_FLOAT */
    GLBK_NORMAL_PACKING_FLOAT,              /* x, y, z, -1..1: float textures, signed ones */
    GLBK_NORMAL_PACKING_UNIT,               /* x, y, z, 0..1 for -1..1: RGBA8, RGB10_A2 */
    GLBK_NORMAL_PACKING_OCTAHEDRAL,         /* x, y on the octahedron about z, -1..1: RG16F, RG8_SNORM */
    GLBK_NORMAL_PACKING_OCTAHEDRAL_UNIT,    /* the same, 0..1 for -1..1: RG8, RGBA8 */
    GLBK_NORMAL_PACKING_COUNT
} glbk_normal_packing;

typedef enum glbk_clip_depth {
    GLBK_CLIP_DEPTH_DEFAULT,                /* = GLBK_CLIP_DEPTH_MINUS_ONE_TO_ONE */
    GLBK_CLIP_DEPTH_MINUS_ONE_TO_ONE,       /* OpenGL; its depth buffers hold 0 near .. 1 far */
    GLBK_CLIP_DEPTH_ZERO_TO_ONE,            /* glClipControl's other one */
    GLBK_CLIP_DEPTH_REVERSED,               /* 1 near .. 0 far, in depth buffers too */
    GLBK_CLIP_DEPTH_COUNT
} glbk_clip_depth;

/* Textures are 2D, of the G-buffer's size, not multisampled. Of a texture that this library has not made, set name,
   width and height of a zeroed glbk_texture; it must be complete (without mipmaps: GL_NEAREST or GL_LINEAR), a depth
   texture without a comparison mode. NULL = not given. */
typedef struct glbk_import {
    const glbk_texture *depth;              /* what a depth buffer holds; or */
    const glbk_texture *positions;          /* floats. 0 in the fourth channel: nothing is seen. Both: places of these,
                                               what is seen and the depth by the other */
    float               world_to_clip[16];  /* by which it was drawn; needed with depth alone. All zero = not known:
                                               then there is no depth but by a depth texture */
    glbk_clip_depth     clip_depth;         /* of world_to_clip and depth */
    float               to_world[16];       /* of positions and normals: rotation, translation; view to world where they
                                               are in view space. All zero = identity */
    float               eye[3];             /* world */
    const glbk_texture *normals;            /* required. Lengths beyond 0.5..1.5: nothing is seen */
    const glbk_texture *geometric;          /* normals of the surfaces; NULL = from the places of neighbouring pixels */
    glbk_normal_packing normal_packing;     /* of both */
    lsamp_material      material;           /* as in glbk_surface, as is first_lobe */
    uint32_t            first_lobe;
    const glbk_texture *color_map;          /* factors of diffuse. Linear: an sRGB texture, or one that holds it so */
    const glbk_texture *gloss_map;          /* as in glbk_surface: pixel for pixel here */
    const glbk_texture *open_map;           /* red: 1 open .. 0 occluded, as glTF has it; else occlusion holds */
    const glbk_texture *entities;           /* unsigned integers, red: from 1, 0 none; else entity holds */
    uint32_t            entity, plane;
    float               occlusion;
} glbk_import;                              /* zero it, then set what you care about */

GLBK_DEF glbk_result glbk_gbuffer_import(glbk_context *ctx, glbk_gbuffer *gbuffer, const glbk_import *import);
/* One pass over all pixels: it reads 2 to 8 texels of yours, 4 to 8 more where it finds normals of surfaces by
   neighbours, and writes 64 bytes. Compiles its program at first use. The G-buffer's own depth is written where it is
   known; yours, by desc.depth, is left as it is, and may be import->depth.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC: what is required is missing, a texture of another size, a matrix that has
            no inverse; those of glbk_program_create at first use */

GLBK_DEF glbk_result glbk_gbuffer_bind(glbk_context *ctx, const glbk_gbuffer *gbuffer,
                                      const glbk_offset *offset);
/* For a program of yours with gbuffer among its library files, which is bound (glbk_begin): the four textures.
   offset   that gbuffer has in the program; NULL = none
   Errors   GLBK_ERR_ARGUMENT */

GLBK_DEF glbk_result glbk_gbuffer_read(glbk_context *ctx, const glbk_gbuffer *gbuffer, uint32_t row, uint32_t rows,
                                       glbk_pixel *pixels);
/* The way back, to look at what a G-buffer holds: rows as glbk_gbuffer_upload takes them. Normals of surfaces and
   tangents are off by up to 5e-5, occlusion by 1 / 131070. Waits for the GPU.
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC */

/* ---- for the techniques' headers: not for you, may change without notice ---- */

GLBK_DEF glbk_result glbk__gbuffer_program(glbk_context *ctx, const glbk_part *part, const char *name,
                                           const char *defines, glbk_program *out);
/* glbk_program_create for a program of one pass over the screen or of compute that uses lib/gbuffer.glsl beside files
   of its own part. */

/* ==== src/gl_gbuffer/begin.h ==== */

/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_GBUFFER_H */

/* ==== implementation ============================================================================================== */

#if defined(GL_GBUFFER_IMPLEMENTATION) && !defined(GL_GBUFFER_IMPLEMENTED)
#define GL_GBUFFER_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== src/shared/mem.h ==== */


/* unit mem: checked sizes, and the caller's allocator with malloc and free as its default */

typedef struct glbk_gbuf__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} glbk_gbuf__allocator;

static inline void *glbk_gbuf__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void glbk_gbuf__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* *out = a * b and 1, or 0 and *out untouched where the product does not fit. */
static inline int glbk_gbuf__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

static inline glbk_gbuf__allocator glbk_gbuf__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    glbk_gbuf__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : glbk_gbuf__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : glbk_gbuf__default_free;
    a.user = user;
    return a;
}

/* NULL where the size is 0 or overflows, so that a caller has one thing to test. */
static inline void *glbk_gbuf__alloc(const glbk_gbuf__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *glbk_gbuf__alloc_array(const glbk_gbuf__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return glbk_gbuf__mul_size(count, item_size, &size) ? glbk_gbuf__alloc(a, size) : NULL;
}

static inline void glbk_gbuf__free(const glbk_gbuf__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/gl_memory.h ==== */


/* unit gl_memory, needs mem: the allocator of a glbk_context (gl_backend.h) */

static inline glbk_gbuf__allocator glbk_gbuf__memory(const glbk_context *ctx)
{
    const glbk_allocator *a = &ctx->system.allocator;
    return glbk_gbuf__allocator_make(a->alloc_fn, a->free_fn, a->user);
}

/* ==== GLSL of src/gl_gbuffer ==== */


static const char *const glbk__glsl_lib_gbuffer_glsl[] = {
    "\n\n#define GLBK_LAMBERT 1u\n"
    "#define GLBK_PHONG 2u\n"
    "#define GLBK_LAFORTUNE 3u\n"
    "#define GLBK_METAL_ROUGH 4u\n"
    "\nstruct glbk_point{\n"
    "vec3 position,normal;\n"
    "vec3 geometric;\n"
    "vec3 tangent;\n"
    "uint kind;\n"
    "vec3 diffuse;\n"
    "vec3 specular;\n"
    "float exponent;\n"
    "float metallic,roughness;\n"
    "uint lobe,lobe_count;\n"
    "float occlusion;\n"
    "uint entity;\n"
    "uint plane;\n"
    "};\n"
    "\n\nbool glbk_read_point(ivec2 at,out glbk_point p)\n"
    "{\n"
    "uvec4 place=texelFetch(glbk_gbuffer_place,at,0),normal=texelFetch(glbk_gbuffer_normal,at,0);\n"
    "uvec4 color=texelFetch(glbk_gbuffer_color,at,0),gloss=texelFetch(glbk_gbuffer_gloss,at,0);\n"
    "vec4 values=uintBitsToFloat(gloss);\n"
    "p.kind=normal.w&0xffu;\n"
    "bool phong=p.kind==GLBK_PHONG,metal=p.kind==GLBK_METAL_ROUGH,lobes=p.kind==GLBK_LAFORTUNE;\n"
    "p.position=uintBitsToFloat(place.xyz);\n"
    "p.entity=place.w;\n"
    "p.normal=uintBitsToFloat(normal.xyz);\n"
    "p.plane=(normal.w>>8)&0xffu;\n"
    "p.occlusion=float(normal.w>>16)/65535.0;\n"
    "p.diffuse=uintBitsToFloat(color.xyz);\n"
    "p.geometric=glbk_unpack_unit(color.w);\n"
    "p.specular=phong?values.xyz:vec3(0.0);\n"
    "p.exponent=phong?values.w:0.0;\n"
    "p.metallic=metal?values.x:0.0;\n"
    "p.roughness=metal?values.y:0.0;\n"
    "p.lobe=lobes?gloss.x:0u;\n"
    "p.lobe_count=lobes?gloss.y:0u;\n"
    "p.tangent=lobes?glbk_unpack_unit(gloss.z):vec3(0.0);\n"
    "return p.kind!=0u;\n"
    "}\n"
};

static const char *const glbk__glsl_lib_gbuffer_bindings_glsl[] = {
    "\nuniform usampler2D glbk_gbuffer_place;\n"
    "uniform usampler2D glbk_gbuffer_normal;\n"
    "uniform usampler2D glbk_gbuffer_color;\n"
    "uniform usampler2D glbk_gbuffer_gloss;\n"
    "uniform sampler2D glbk_gbuffer_color_map;\n"
    "uniform sampler2D glbk_gbuffer_gloss_map;\n"
    "uniform sampler2D glbk_gbuffer_normal_map;\n"
    "uniform sampler2D glbk_gbuffer_place_in;\n"
    "uniform sampler2D glbk_gbuffer_depth_in;\n"
    "uniform sampler2D glbk_gbuffer_normal_in;\n"
    "uniform sampler2D glbk_gbuffer_flat_in;\n"
    "uniform sampler2D glbk_gbuffer_open_in;\n"
    "uniform usampler2D glbk_gbuffer_entity_in;\n"
};

static const char *const glbk__glsl_lib_gbuffer_drawn_glsl[] = {
    "\nlayout(std140)uniform glbk_gbuffer_drawn_block{\n"
    "mat4 world;\n"
    "mat4 clip;\n"
    "uvec4 numbers;\n"
    "uvec4 lobes;\n"
    "vec4 diffuse;\n"
    "vec4 gloss;\n"
    "vec4 eye;\n"
    "vec4 values;\n"
    "}glbk_gbuffer_drawn;\n"
};

static const char *const glbk__glsl_lib_gbuffer_imported_glsl[] = {
    "\nlayout(std140)uniform glbk_gbuffer_imported_block{\n"
    "mat4 from_clip;\n"
    "mat4 to_clip;\n"
    "mat4 to_world;\n"
    "uvec4 numbers;\n"
    "uvec4 lobes;\n"
    "uvec4 how;\n"
    "vec4 diffuse;\n"
    "vec4 gloss;\n"
    "vec4 eye;\n"
    "vec4 depths;\n"
    "}glbk_gbuffer_imported;\n"
};

static const char *const glbk__glsl_lib_gbuffer_pack_glsl[] = {
    "\nvec3 glbk_unit(vec3 v)\n"
    "{\n"
    "float d=dot(v,v);\n"
    "return d>0.0?v*inversesqrt(d):vec3(0.0);\n"
    "}\n"
    "\nvec3 glbk_unit_of_square(vec2 p)\n"
    "{\n"
    "float z=1.0-abs(p.x)-abs(p.y),t=max(-z,0.0);\n"
    "return glbk_unit(vec3(p.x+(p.x>=0.0? -t:t),p.y+(p.y>=0.0? -t:t),z));\n"
    "}\n"
    "\nuint glbk_pack_unit(vec3 n)\n"
    "{\n"
    "float sum=abs(n.x)+abs(n.y)+abs(n.z);\n"
    "if(!(sum>0.0))return 0xffffffffu;\n"
    "n/=sum;\n"
    "vec2 p=n.z>=0.0?n.xy:(1.0-abs(n.yx))*vec2(n.x>=0.0?1.0: -1.0,n.y>=0.0?1.0: -1.0);\n"
    "uvec2 q=uvec2(floor(clamp(p*0.5+0.5,0.0,1.0)*65534.0+0.5));\n"
    "return q.x|(q.y<<16);\n"
    "}\n"
    "\nvec3 glbk_unpack_unit(uint bits)\n"
    "{\n"
    "if(bits==0xffffffffu)return vec3(0.0);\n"
    "return glbk_unit_of_square(vec2(float(bits&0xffffu),float(bits>>16))*(2.0/65534.0)-1.0);\n"
    "}\n"
};

static const char *const glbk__glsl_lib_gbuffer_write_glsl[] = {
    "\n\nlayout(location=0)out uvec4 glbk_out_place;\n"
    "layout(location=1)out uvec4 glbk_out_normal;\n"
    "layout(location=2)out uvec4 glbk_out_color;\n"
    "layout(location=3)out uvec4 glbk_out_gloss;\n"
    "\n\nvoid glbk_write_surface(vec3 place,vec3 n,vec3 flat_n,vec3 tangent,uvec4 numbers,uvec4 lobes,vec3 diffuse,\n"
    "vec4 gloss,vec3 map,float occlusion)\n"
    "{\n"
    "if(numbers.x==2u)gloss.xyz*=map;\n"
    "if(numbers.x==4u)gloss.xy*=map.zy;\n"
    "uint shade=uint(clamp(occlusion,0.0,1.0)*65535.0+0.5);\n"
    "glbk_out_place=uvec4(floatBitsToUint(place),numbers.y);\n"
    "glbk_out_normal=uvec4(floatBitsToUint(n),numbers.x|(numbers.z<<8)|(shade<<16));\n"
    "glbk_out_color=uvec4(floatBitsToUint(diffuse),glbk_pack_unit(flat_n));\n"
    "glbk_out_gloss=numbers.x==3u?uvec4(lobes.xy,glbk_pack_unit(tangent),0u):floatBitsToUint(gloss);\n"
    "}\n"
};

static const char *const glbk__glsl_prog_gbuffer_draw_frag[] = {
    "\n\n\n\nin vec3 glbk_place,glbk_facing;\n"
    "in vec2 glbk_uv;\n"
    "in vec4 glbk_along;\n"
    "\nvoid main()\n"
    "{\n"
    "uvec4 numbers=glbk_gbuffer_drawn.numbers;\n"
    "vec3 view=glbk_gbuffer_drawn.eye.xyz-glbk_place;\n"
    "vec3 flat_n=glbk_unit(cross(dFdx(glbk_place),dFdy(glbk_place)));\n"
    "if(dot(flat_n,flat_n)==0.0)flat_n=glbk_unit(glbk_facing);\n"
    "if(dot(flat_n,view)<0.0)flat_n= -flat_n;\n"
    "vec3 n=dot(glbk_facing,glbk_facing)>0.0?glbk_unit(glbk_facing):flat_n;\n"
    "if(dot(n,flat_n)<0.0)n= -n;\n"
    "vec3 t=glbk_unit(glbk_along.xyz-n*dot(glbk_along.xyz,n)),map=vec3(1.0);\n"
    "vec4 color=glbk_gbuffer_drawn.diffuse;\n"
    "if((numbers.w&4u)!=0u){\n"
    "vec3 bump=texture(glbk_gbuffer_normal_map,glbk_uv).xyz*2.0-1.0;\n"
    "bump.y*=glbk_along.w<0.0? -1.0:1.0;\n"
    "if(dot(t,t)>0.0)n=glbk_unit(t*bump.x+cross(n,t)*bump.y+n*bump.z);\n"
    "}\n"
    "if((numbers.w&1u)!=0u)color*=texture(glbk_gbuffer_color_map,glbk_uv);\n"
    "if((numbers.w&2u)!=0u)map=texture(glbk_gbuffer_gloss_map,glbk_uv).xyz;\n"
    "if(color.a<glbk_gbuffer_drawn.values.x)discard;\n"
    "glbk_write_surface(glbk_place,n,flat_n,t,numbers,glbk_gbuffer_drawn.lobes,color.xyz,\n"
    "glbk_gbuffer_drawn.gloss,map,glbk_gbuffer_drawn.values.y);\n"
    "}\n"
};

static const char *const glbk__glsl_prog_gbuffer_draw_vert[] = {
    "\n\n#ifndef GBUFFER_POSITION\n"
    "#define GBUFFER_POSITION 0\n"
    "#define GBUFFER_NORMAL 1\n"
    "#define GBUFFER_UV 2\n"
    "#define GBUFFER_TANGENT 3\n"
    "#endif\n"
    "layout(location=GBUFFER_POSITION)in vec3 position;\n"
    "#if GBUFFER_NORMAL >= 0\n"
    "layout(location=GBUFFER_NORMAL)in vec3 normal;\n"
    "#else\n"
    "const vec3 normal=vec3(0.0);\n"
    "#endif\n"
    "#if GBUFFER_UV >= 0\n"
    "layout(location=GBUFFER_UV)in vec2 uv;\n"
    "#else\n"
    "const vec2 uv=vec2(0.0);\n"
    "#endif\n"
    "#if GBUFFER_TANGENT >= 0\n"
    "layout(location=GBUFFER_TANGENT)in vec4 tangent;\n"
    "#else\n"
    "const vec4 tangent=vec4(0.0);\n"
    "#endif\n"
    "invariant gl_Position;\n"
    "out vec3 glbk_place,glbk_facing;\n"
    "out vec2 glbk_uv;\n"
    "out vec4 glbk_along;\n"
    "\nvoid main()\n"
    "{\n"
    "mat3 m=mat3(glbk_gbuffer_drawn.world);\n"
    "glbk_place=(glbk_gbuffer_drawn.world*vec4(position,1.0)).xyz;\n"
    "glbk_facing=mat3(cross(m[1],m[2]),cross(m[2],m[0]),cross(m[0],m[1]))*normal;\n"
    "glbk_along=vec4(m*tangent.xyz,tangent.w);\n"
    "glbk_uv=uv;\n"
    "gl_Position=glbk_gbuffer_drawn.clip*vec4(glbk_place,1.0);\n"
    "}\n"
};

static const char *const glbk__glsl_prog_gbuffer_import_frag[] = {
    "\n\n\n\n#ifndef GBUFFER_DEPTH\n"
    "#define GBUFFER_DEPTH 0\n"
    "#endif\n"
    "\nconst uint has_places=1u,has_depth=2u,has_flat=4u,has_colors=8u,has_gloss=16u,has_occlusion=32u,\n"
    "has_entities=64u,reversed=128u;\n"
    "\nbool has(uint what){return(glbk_gbuffer_imported.how.x&what)!=0u;}\n"
    "float depth_at(ivec2 at){return texelFetch(glbk_gbuffer_depth_in,at,0).x;}\n"
    "\n\nvec4 place_at(ivec2 at)\n"
    "{\n"
    "if(at.x<0||at.y<0||at.x>=int(glbk_gbuffer_imported.how.z)||at.y>=int(glbk_gbuffer_imported.how.w))\n"
    "return vec4(0.0);\n"
    "float depth=has(has_depth)?depth_at(at):0.5;\n"
    "bool seen=has(reversed)?depth>0.0:depth<1.0;\n"
    "if(!seen)return vec4(0.0);\n"
    "if(has(has_places)){\n"
    "vec4 p=texelFetch(glbk_gbuffer_place_in,at,0);\n"
    "return p.w==0.0?vec4(0.0):vec4((glbk_gbuffer_imported.to_world*vec4(p.xyz,1.0)).xyz,1.0);\n"
    "}\n"
    "vec2 size=vec2(glbk_gbuffer_imported.how.zw),xy=(vec2(at)+0.5)/size*2.0-1.0;\n"
    "vec4 scale=glbk_gbuffer_imported.depths;\n"
    "vec4 p=glbk_gbuffer_imported.from_clip*vec4(xy,depth*scale.x+scale.y,1.0);\n"
    "return vec4(p.xyz/p.w,1.0);\n"
    "}\n"
    "\n\nvec3 normal_of(vec3 v)\n"
    "{\n"
    "uint packing=glbk_gbuffer_imported.how.y;\n"
    "if(packing==2u||packing==4u)v=v*2.0-1.0;\n"
    "if(packing>=3u)v=glbk_unit_of_square(v.xy);\n"
    "float d=dot(v,v);\n"
    "if(!(d>0.25&&d<2.25))return vec3(0.0);\n"
    "return glbk_unit(mat3(glbk_gbuffer_imported.to_world)*v);\n"
    "}\n"
    "\n\nvec3 step_along(ivec2 at,ivec2 by,vec3 p,vec3 n)\n"
    "{\n"
    "vec4 a=place_at(at+by),b=place_at(at-by);\n"
    "vec3 da=a.xyz-p,db=p-b.xyz;\n"
    "float off_a=dot(da,n)*dot(da,n)*dot(db,db),off_b=dot(db,n)*dot(db,n)*dot(da,da);\n"
    "bool first=a.w!=0.0&&(b.w==0.0||off_a<=off_b);\n"
    "return first?da:b.w!=0.0?db:vec3(0.0);\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy);\n"
    "uvec4 numbers=glbk_gbuffer_imported.numbers;\n"
    "vec4 p=place_at(at);\n"
    "vec3 n=normal_of(texelFetch(glbk_gbuffer_normal_in,at,0).xyz);\n"
    "if(p.w==0.0||dot(n,n)==0.0)discard;\n"
    "vec3 view=glbk_gbuffer_imported.eye.xyz-p.xyz;\n"
    "vec3 flat_n=has(has_flat)?normal_of(texelFetch(glbk_gbuffer_flat_in,at,0).xyz)\n"
    ":glbk_unit(cross(step_along(at,ivec2(1,0),p.xyz,n),\n"
    "step_along(at,ivec2(0,1),p.xyz,n)));\n"
    "if(dot(flat_n,view)<0.0)flat_n= -flat_n;\n"
    "if(dot(n,flat_n)<0.0)n= -n;\n"
    "if(!has(has_flat)&&dot(n,flat_n)<0.25){\n"
    "flat_n=dot(n,view)<0.0? -n:n;\n"
    "n=flat_n;\n"
    "}\n"
    "vec3 color=glbk_gbuffer_imported.diffuse.xyz,map=vec3(1.0);\n"
    "float occlusion=glbk_gbuffer_imported.depths.z;\n"
    "if(has(has_colors))color*=texelFetch(glbk_gbuffer_color_map,at,0).xyz;\n"
    "if(has(has_gloss))map=texelFetch(glbk_gbuffer_gloss_map,at,0).xyz;\n"
    "if(has(has_occlusion))occlusion=1.0-texelFetch(glbk_gbuffer_open_in,at,0).x;\n"
    "if(has(has_entities))numbers.y=texelFetch(glbk_gbuffer_entity_in,at,0).x;\n"
    "#if GBUFFER_DEPTH\n"
    "float depth=0.0;\n"
    "if(has(has_depth)){\n"
    "depth=depth_at(at);\n"
    "if(has(reversed))depth=1.0-depth;\n"
    "}else{\n"
    "vec4 clip=glbk_gbuffer_imported.to_clip*vec4(p.xyz,1.0);\n"
    "if(clip.w>0.0)depth=clamp(clip.z/clip.w*0.5+0.5,0.0,1.0);\n"
    "}\n"
    "gl_FragDepth=depth;\n"
    "#endif\n"
    "glbk_write_surface(p.xyz,n,flat_n,vec3(0.0),numbers,glbk_gbuffer_imported.lobes,color,\n"
    "glbk_gbuffer_imported.gloss,map,occlusion);\n"
    "}\n"
};

static const glbk_file glbk__gbuffer_files[] = {
    { "lib/gbuffer.glsl", glbk__glsl_lib_gbuffer_glsl, 1, "gbuffer_bindings gbuffer_pack", "",
      "", "" },
    { "lib/gbuffer_bindings.glsl", glbk__glsl_lib_gbuffer_bindings_glsl, 1, "", "",
      "", "" },
    { "lib/gbuffer_drawn.glsl", glbk__glsl_lib_gbuffer_drawn_glsl, 1, "", "",
      "", "glbk_gbuffer_drawn" },
    { "lib/gbuffer_imported.glsl", glbk__glsl_lib_gbuffer_imported_glsl, 1, "", "",
      "", "glbk_gbuffer_imported" },
    { "lib/gbuffer_pack.glsl", glbk__glsl_lib_gbuffer_pack_glsl, 1, "", "",
      "", "" },
    { "lib/gbuffer_write.glsl", glbk__glsl_lib_gbuffer_write_glsl, 1, "gbuffer_pack gbuffer_drawn", "",
      "", "" },
    { "prog/gbuffer_draw.frag", glbk__glsl_prog_gbuffer_draw_frag, 1, "gbuffer_bindings gbuffer_drawn gbuffer_write gbuffer_drawn", "gbuffer_draw.vert",
      "| GBUFFER_POSITION=5 GBUFFER_NORMAL=-1 GBUFFER_UV=-1 GBUFFER_TANGENT=-1", "" },
    { "prog/gbuffer_draw.vert", glbk__glsl_prog_gbuffer_draw_vert, 1, "gbuffer_drawn gbuffer_drawn", "",
      "", "" },
    { "prog/gbuffer_import.frag", glbk__glsl_prog_gbuffer_import_frag, 1, "gbuffer_bindings gbuffer_imported gbuffer_write gbuffer_imported", "screen.vert",
      "GBUFFER_DEPTH=0 | GBUFFER_DEPTH=1", "" }
};


/* ==== src/gl_gbuffer/part.h ==== */

/* ---- gbuffer: this header's GLSL, textures and blocks, by which programs find them ---- */

GLBK__PART_CODE(gbuffer, GBUFFER)

/* The part as the techniques' own programs use it: the files that read. A linker leaves out those that draw and
   import. */
#define GLBK__GBUFFER_FILE(name, texts, uses) { name, texts, sizeof texts / sizeof texts[0], uses, "", "", "" }
static const glbk_file glbk__gbuffer_reads[] = {
    GLBK__GBUFFER_FILE("lib/gbuffer.glsl", glbk__glsl_lib_gbuffer_glsl, "gbuffer_bindings gbuffer_pack"),
    GLBK__GBUFFER_FILE("lib/gbuffer_bindings.glsl", glbk__glsl_lib_gbuffer_bindings_glsl, ""),
    GLBK__GBUFFER_FILE("lib/gbuffer_pack.glsl", glbk__glsl_lib_gbuffer_pack_glsl, "")
};
static const glbk_part glbk__gbuffer_reader = {
    "gbuffer", glbk__gbuffer_reads, sizeof glbk__gbuffer_reads / sizeof glbk__gbuffer_reads[0], glbk__gbuffer_units,
    glbk__gbuffer_bindings
};

/* ==== src/gl_gbuffer/making.h ==== */

/* ---- gbuffer: creating, uploading, reading ---- */

static glbk_result glbk__gbuffer_bad(const glbk_context *ctx, const char *function, const char *field, const char *text)
{
    return glbk__bad(ctx, GLBK_ERR_DESC, function, field, text);
}

/* 1 where a number is within its range; else it is logged. */
static int glbk__gbuffer_within(const glbk_context *ctx, const char *function, const char *field, double value,
                                double low, double high)
{
    if (value >= low && value <= high) return 1;
    (void)glbk__bad_range(ctx, GLBK_ERR_DESC, function, field, value, low, high);
    return 0;
}

static int glbk__gbuffer_material_valid(const glbk_context *ctx, const char *function, const lsamp_material *m,
                                        uint32_t plane, float occlusion)
{
    return glbk__gbuffer_within(ctx, function, "material.kind", m->kind, 0, LSAMP_MATERIAL_COUNT - 1) &&
           glbk__gbuffer_within(ctx, function, "material.lobe_count", m->lobe_count, 0, LSAMP_MAX_LOBES) &&
           glbk__gbuffer_within(ctx, function, "plane", plane, 0, 255) &&
           glbk__gbuffer_within(ctx, function, "occlusion", (double)occlusion, 0, 1);
}

static uint32_t glbk__gbuffer_kind(const lsamp_material *m)
{
    return m->kind == LSAMP_MATERIAL_DEFAULT ? (uint32_t)LSAMP_MATERIAL_LAMBERT : (uint32_t)m->kind;
}

/* The four words that a material keeps besides its diffuse colour and its lobes. */
static void glbk__gbuffer_gloss(const lsamp_material *m, float gloss[4])
{
    memset(gloss, 0, 4 * sizeof *gloss);
    if (m->kind == LSAMP_MATERIAL_PHONG) {
        memcpy(gloss, m->specular, sizeof m->specular);
        gloss[3] = m->exponent;
    } else if (m->kind == LSAMP_MATERIAL_METAL_ROUGH) {
        gloss[0] = m->metallic;
        gloss[1] = m->roughness;
    }
}

static int glbk__gbuffer_is_zero(const float *v, int count)
{
    int i;
    for (i = 0; i < count && v[i] == 0; i++) {}
    return i == count;
}

static void glbk__gbuffer_matrix(const float *from, float to[16])
{
    memcpy(to, from, 16 * sizeof *to);
    if (glbk__gbuffer_is_zero(from, 16)) to[0] = to[5] = to[10] = to[15] = 1;
}

/* Locations with their default, each within 0..15 and there once. */
static glbk_result glbk__gbuffer_attributes(const glbk_context *ctx, const glbk_attributes *from, glbk_attributes *to)
{
    int32_t at[4];
    int i, k;
    *to = *from;
    if (!from->position && !from->normal && !from->uv && !from->tangent) to->normal = 1, to->uv = 2, to->tangent = 3;
    at[0] = to->position;
    at[1] = to->normal;
    at[2] = to->uv;
    at[3] = to->tangent;
    if (at[0] < 0) return glbk__gbuffer_bad(ctx, "glbk_gbuffer_create", "desc.attributes.position", "is below 0");
    for (i = 0; i < 4; i++) {
        if (at[i] > 15) return glbk__gbuffer_bad(ctx, "glbk_gbuffer_create", "desc.attributes", "has one above 15");
        for (k = 0; k < i; k++)
            if (at[i] >= 0 && at[i] == at[k])
                return glbk__gbuffer_bad(ctx, "glbk_gbuffer_create", "desc.attributes", "has one location twice");
    }
    return GLBK_OK;
}

static glbk_result glbk__gbuffer_make(glbk_context *ctx, const glbk_gbuffer_desc *d, glbk_gbuffer *out)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result = GLBK_OK;
    int i;

    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    texture.width = out->width;
    texture.height = out->height;
    texture.format = GLBK_FORMAT_RGBA32UI;
    for (i = 0; i < 4 && result == GLBK_OK; i++) {
        result = glbk_texture_create(ctx, &texture, &out->words[i]);
        target.color[i] = &out->words[i];
    }
    if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &out->colors);
    texture.format = GLBK_FORMAT_DEPTH32F;
    out->own_depth = !d->depth;
    if (d->depth) out->depth = *d->depth;
    else if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &out->depth);
    target.depth = &out->depth;
    if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &out->target);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_gbuffer_drawn), NULL, &out->drawn);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_gbuffer_imported), NULL, &out->imported);
    return result;
}

/* Words of 0: nothing is seen. */
static glbk_result glbk__gbuffer_clear_words(glbk_context *ctx, glbk_gbuffer *g)
{
    glbk_gbuf__allocator memory = glbk_gbuf__memory(ctx);
    const size_t count = 4 * (size_t)g->width;
    uint32_t *row = (uint32_t *)glbk_gbuf__alloc_array(&memory, count, sizeof *row), y;
    glbk_result result = row ? GLBK_OK : GLBK_ERR_ALLOC;
    int i;
    if (row) memset(row, 0, count * sizeof *row);
    for (i = 0; i < 4; i++)
        for (y = 0; y < g->height && result == GLBK_OK; y++)
            result = glbk_texture_update(ctx, &g->words[i], 0, 0, y, 0, g->width, 1, 1, row);
    glbk_gbuf__free(&memory, row);
    return result;
}

GLBK_DEF glbk_result glbk_gbuffer_create(glbk_context *ctx, const glbk_gbuffer_desc *d, glbk_gbuffer *out)
{
    glbk_result result;
    if (!out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!ctx || !d) return GLBK_ERR_ARGUMENT;
    if (!d->width || !d->height) return glbk__gbuffer_bad(ctx, __func__, "desc.width or height", "is 0");
    if (d->depth && (d->depth->width != d->width || d->depth->height != d->height))
        return glbk__bad(ctx, GLBK_ERR_MISMATCH, __func__, "desc.depth", "is of another size");
    result = glbk__gbuffer_attributes(ctx, &d->attributes, &out->attributes);
    if (result == GLBK_OK) {
        out->width = d->width;
        out->height = d->height;
        result = glbk__gbuffer_make(ctx, d, out);
    }
    if (result == GLBK_OK) result = glbk__gbuffer_clear_words(ctx, out);
    result = glbk__made(ctx, result);
    if (result != GLBK_OK) glbk_gbuffer_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_gbuffer_free(glbk_context *ctx, glbk_gbuffer *g)
{
    int i;
    if (!g) return;
    glbk_program_free(ctx, &g->draw);
    glbk_program_free(ctx, &g->take);
    glbk_target_free(ctx, &g->target);
    glbk_target_free(ctx, &g->colors);
    for (i = 0; i < 4; i++) glbk_texture_free(ctx, &g->words[i]);
    if (g->own_depth) glbk_texture_free(ctx, &g->depth);
    glbk_buffer_free(ctx, &g->drawn);
    glbk_buffer_free(ctx, &g->imported);
    memset(g, 0, sizeof *g);
}

/* A unit vector in 32 bits, octahedral, as glbk_unpack_unit of lib/gbuffer_pack.glsl reads it; ~0 for zero. */
static uint32_t glbk__gbuffer_pack_unit(const float *v)
{
    float ax = v[0] < 0 ? -v[0] : v[0], ay = v[1] < 0 ? -v[1] : v[1], az = v[2] < 0 ? -v[2] : v[2];
    float sum = ax + ay + az, x, y;

    if (!(sum > 0)) return 0xffffffffu;
    x = v[0] / sum;
    y = v[1] / sum;
    if (v[2] < 0) {
        x = (1 - ay / sum) * (v[0] < 0 ? -1.0f : 1.0f);
        y = (1 - ax / sum) * (v[1] < 0 ? -1.0f : 1.0f);
    }
    x = (x * 0.5f + 0.5f) * 65534.0f + 0.5f;
    y = (y * 0.5f + 0.5f) * 65534.0f + 0.5f;
    return (uint32_t)(x > 0 ? x : 0) | (uint32_t)(y > 0 ? y : 0) << 16;
}

static void glbk__gbuffer_unpack_unit(uint32_t bits, float *v)
{
    float x = (float)(bits & 0xffffu) * (2.0f / 65534.0f) - 1, y = (float)(bits >> 16) * (2.0f / 65534.0f) - 1;
    float ax = x < 0 ? -x : x, ay = y < 0 ? -y : y, z = 1 - ax - ay, t = z < 0 ? -z : 0, size;

    memset(v, 0, 3 * sizeof *v);
    if (bits == 0xffffffffu) return;
    x += x < 0 ? t : -t;
    y += y < 0 ? t : -t;
    size = sqrtf(x * x + y * y + z * z);
    v[0] = x / size;
    v[1] = y / size;
    v[2] = z / size;
}

/* Four words of each of the four textures. A normal that is 0 or not finite leaves the pixel empty. */
static void glbk__gbuffer_words(const glbk_pixel *p, uint32_t words[4][4])
{
    const lsamp_material *m = &p->material;
    const float *n = p->normal;
    const float d = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    const float shade = p->occlusion > 0 ? p->occlusion < 1 ? p->occlusion : 1.0f : 0.0f;
    float gloss[4];

    memset(words, 0, 16 * sizeof words[0][0]);
    if (!(d > 0 && d < 3e38f)) return;
    memcpy(words[0], p->position, 12);
    words[0][3] = p->entity;
    memcpy(words[1], n, 12);
    words[1][3] = glbk__gbuffer_kind(m) | (p->plane & 255u) << 8 | (uint32_t)(shade * 65535.0f + 0.5f) << 16;
    memcpy(words[2], m->diffuse, 12);
    words[2][3] = glbk__gbuffer_pack_unit(glbk__gbuffer_is_zero(p->geometric, 3) ? n : p->geometric);
    glbk__gbuffer_gloss(m, gloss);
    memcpy(words[3], gloss, sizeof gloss);
    if (m->kind != LSAMP_MATERIAL_LAFORTUNE) return;
    words[3][0] = p->first_lobe;
    words[3][1] = m->lobe_count;
    words[3][2] = glbk__gbuffer_pack_unit(p->tangent);
}

static void glbk__gbuffer_pixel(uint32_t words[4][4], glbk_pixel *p)
{
    lsamp_material *m = &p->material;
    float gloss[4];

    memset(p, 0, sizeof *p);
    if (!(words[1][3] & 255u)) return;
    memcpy(p->position, words[0], 12);
    p->entity = words[0][3];
    memcpy(p->normal, words[1], 12);
    m->kind = (lsamp_material_kind)(words[1][3] & 255u);
    p->plane = words[1][3] >> 8 & 255u;
    p->occlusion = (float)(words[1][3] >> 16) / 65535.0f;
    memcpy(m->diffuse, words[2], 12);
    glbk__gbuffer_unpack_unit(words[2][3], p->geometric);
    memcpy(gloss, words[3], sizeof gloss);
    if (m->kind == LSAMP_MATERIAL_PHONG) {
        memcpy(m->specular, gloss, sizeof m->specular);
        m->exponent = gloss[3];
    } else if (m->kind == LSAMP_MATERIAL_METAL_ROUGH) {
        m->metallic = gloss[0];
        m->roughness = gloss[1];
    } else if (m->kind == LSAMP_MATERIAL_LAFORTUNE) {
        p->first_lobe = words[3][0];
        m->lobe_count = words[3][1];
        glbk__gbuffer_unpack_unit(words[3][2], p->tangent);
    }
}

static int glbk__gbuffer_has_rows(const glbk_gbuffer *g, uint32_t row, uint32_t rows)
{
    return g && g->colors.name && rows && row < g->height && rows <= g->height - row;
}

GLBK_DEF glbk_result glbk_gbuffer_upload(glbk_context *ctx, glbk_gbuffer *g, uint32_t row, uint32_t rows,
                                         const glbk_pixel *pixels)
{
    glbk_gbuf__allocator memory;
    size_t count, i;
    uint32_t *words, pixel[4][4];
    glbk_result result = GLBK_OK;
    int k;

    if (!ctx || !pixels || !glbk__gbuffer_has_rows(g, row, rows))
        return glbk__bad(ctx, GLBK_ERR_ARGUMENT, __func__, "row, rows, pixels or gbuffer", "is NULL or out of range");
    memory = glbk_gbuf__memory(ctx);
    count = (size_t)g->width * rows;
    words = (uint32_t *)glbk_gbuf__alloc_array(&memory, count, 64);
    if (!words) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i++) {
        glbk__gbuffer_words(&pixels[i], pixel);
        for (k = 0; k < 4; k++) memcpy(words + 4 * ((size_t)k * count + i), pixel[k], sizeof pixel[k]);
    }
    for (k = 0; k < 4 && result == GLBK_OK; k++)
        result = glbk_texture_update(ctx, &g->words[k], 0, 0, row, 0, g->width, rows, 1, words + 4 * (size_t)k * count);
    glbk_gbuf__free(&memory, words);
    g->has_depth = g->has_clip = 0;
    return result;
}

GLBK_DEF glbk_result glbk_gbuffer_read(glbk_context *ctx, const glbk_gbuffer *g, uint32_t row, uint32_t rows,
                                       glbk_pixel *pixels)
{
    glbk_gbuf__allocator memory;
    size_t count, i;
    uint32_t *words, pixel[4][4], k;
    glbk_result result = GLBK_OK;

    if (!ctx || !pixels || !glbk__gbuffer_has_rows(g, row, rows))
        return glbk__bad(ctx, GLBK_ERR_ARGUMENT, __func__, "row, rows, pixels or gbuffer", "is NULL or out of range");
    memory = glbk_gbuf__memory(ctx);
    count = (size_t)g->width * rows;
    words = (uint32_t *)glbk_gbuf__alloc_array(&memory, count, 64);
    if (!words) return GLBK_ERR_ALLOC;
    for (k = 0; k < 4 && result == GLBK_OK; k++)
        result = glbk_target_read(ctx, &g->colors, k, 0, row, g->width, rows, words + 4 * (size_t)k * count);
    for (i = 0; i < count && result == GLBK_OK; i++) {
        for (k = 0; k < 4; k++) memcpy(pixel[k], words + 4 * ((size_t)k * count + i), sizeof pixel[k]);
        glbk__gbuffer_pixel(pixel, &pixels[i]);
    }
    glbk_gbuf__free(&memory, words);
    return result;
}

GLBK_DEF glbk_result glbk_gbuffer_bind(glbk_context *ctx, const glbk_gbuffer *g, const glbk_offset *offset)
{
    const uint32_t first = GLBK_SLOT_glbk_gbuffer_place + glbk__offset(offset).unit;
    uint32_t i;
    if (!ctx || !g || !g->colors.name)
        return glbk__bad(ctx, GLBK_ERR_ARGUMENT, __func__, "gbuffer", "is NULL or was not created");
    for (i = 0; i < 4; i++) glbk_bind_texture(ctx, first + i, &g->words[i]);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk__gbuffer_program(glbk_context *ctx, const glbk_part *part, const char *name,
                                           const char *defines, glbk_program *out)
{
    return glbk__program_of_parts(ctx, part, &glbk__gbuffer_reader, name, defines, out);
}

/* ==== src/gl_gbuffer/drawing.h ==== */

/* ---- gbuffer: drawing ---- */

static glbk_result glbk__gbuffer_draw_program(glbk_context *ctx, glbk_gbuffer *g)
{
    static const char *const names[4] = { "GBUFFER_POSITION=", " GBUFFER_NORMAL=", " GBUFFER_UV=",
                                          " GBUFFER_TANGENT=" };
    int32_t at[4];
    char defines[100];
    size_t used = 0;
    int i;

    if (g->draw.name) return GLBK_OK;
    at[0] = g->attributes.position;
    at[1] = g->attributes.normal;
    at[2] = g->attributes.uv;
    at[3] = g->attributes.tangent;
    for (i = 0; i < 4; i++) {
        memcpy(defines + used, names[i], strlen(names[i]));
        used += strlen(names[i]);
        if (at[i] < 0) defines[used++] = '-';
        if (at[i] > 9) defines[used++] = '1';
        defines[used++] = at[i] < 0 ? '1' : (char)('0' + at[i] % 10);
    }
    defines[used] = 0;
    return glbk_program_create(ctx, glbk_gbuffer_part(), "gbuffer_draw.frag", defines, &g->draw);
}

/* Binds and clears the target: an attachment is cleared by 0 whether the context draws floats or not. */
static glbk_result glbk__gbuffer_start(glbk_context *ctx, const glbk_target *target, glbk_depth depth,
                                       glbk_program *program)
{
    static const float zero[4] = { 0, 0, 0, 0 };
    glbk_pass pass;
    glbk_result result;
    uint32_t i;

    memset(&pass, 0, sizeof pass);
    pass.target = target;
    pass.depth = depth;
    result = glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    for (i = 0; i < 4; i++) glbk_clear(ctx, target, i, zero);
    if (depth != GLBK_DEPTH_OFF) glbk_clear_depth(ctx, 1);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_gbuffer_begin(glbk_context *ctx, glbk_gbuffer *g, const float world_to_clip[16],
                                        const float eye[3])
{
    glbk_result result;
    uint32_t i;

    if (!ctx || !g || !g->target.name || !world_to_clip || !eye)
        return glbk__bad(ctx, GLBK_ERR_ARGUMENT, __func__, "gbuffer, world_to_clip or eye",
                         "is NULL or was not created");
    result = glbk__gbuffer_draw_program(ctx, g);
    if (result == GLBK_OK) result = glbk__gbuffer_start(ctx, &g->target, GLBK_DEPTH_LESS, &g->draw);
    if (result != GLBK_OK) return result;
    /* Until an object has a map. */
    for (i = 0; i < 3; i++) glbk_bind_texture(ctx, GLBK_SLOT_glbk_gbuffer_color_map + i, NULL);
    memcpy(g->clip, world_to_clip, sizeof g->clip);
    memcpy(g->eye, eye, sizeof g->eye);
    g->has_depth = g->has_clip = 1;
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_gbuffer_object(glbk_context *ctx, glbk_gbuffer *g, const glbk_surface *s)
{
    glbk_gbuffer_drawn drawn;
    glbk_result result;

    if (!ctx || !g || !g->target.name || !s)
        return glbk__bad(ctx, GLBK_ERR_ARGUMENT, __func__, "gbuffer or surface", "is NULL or was not created");
    if (!g->draw.name || !g->has_clip)
        return glbk__bad(ctx, GLBK_ERR_ORDER, __func__, "gbuffer", "was not begun: glbk_gbuffer_begin");
    if (!glbk__gbuffer_material_valid(ctx, __func__, &s->material, s->plane, s->occlusion)) return GLBK_ERR_DESC;
    memset(&drawn, 0, sizeof drawn);
    glbk__gbuffer_matrix(s->world, drawn.world);
    memcpy(drawn.clip, g->clip, sizeof drawn.clip);
    memcpy(drawn.eye, g->eye, sizeof g->eye);
    memcpy(drawn.diffuse, s->material.diffuse, sizeof s->material.diffuse);
    drawn.diffuse[3] = s->alpha > 0 ? s->alpha : 1.0f;
    drawn.values[0] = s->alpha_cutoff;
    drawn.values[1] = s->occlusion;
    drawn.numbers[0] = glbk__gbuffer_kind(&s->material);
    drawn.numbers[1] = s->entity;
    drawn.numbers[2] = s->plane;
    drawn.numbers[3] = (s->color_map ? 1u : 0u) | (s->gloss_map ? 2u : 0u) | (s->normal_map ? 4u : 0u);
    drawn.lobes[0] = s->first_lobe;
    drawn.lobes[1] = s->material.lobe_count;
    glbk__gbuffer_gloss(&s->material, drawn.gloss);
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_gbuffer_drawn, &g->drawn, &drawn);
    if (result != GLBK_OK) return result;
    if (s->color_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_gbuffer_color_map, s->color_map);
    if (s->gloss_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_gbuffer_gloss_map, s->gloss_map);
    if (s->normal_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_gbuffer_normal_map, s->normal_map);
    return GLBK_OK;
}

/* ==== src/gl_gbuffer/importing.h ==== */

/* ---- gbuffer: from textures of the user's own ---- */

enum {
    GLBK__IMPORT_PLACES = 1, GLBK__IMPORT_DEPTH = 2, GLBK__IMPORT_FLAT = 4, GLBK__IMPORT_COLORS = 8,
    GLBK__IMPORT_GLOSS = 16, GLBK__IMPORT_OPEN = 32, GLBK__IMPORT_ENTITIES = 64, GLBK__IMPORT_REVERSED = 128
};

/* The inverse of a matrix by elimination with pivots, or 0. */
static int glbk__gbuffer_invert(const float *from, float *to)
{
    double m[4][8], keep;
    int c, r, k, best;

    for (r = 0; r < 4; r++)
        for (c = 0; c < 4; c++) {
            m[r][c] = (double)from[4 * c + r];
            m[r][4 + c] = r == c ? 1 : 0;
        }
    for (c = 0; c < 4; c++) {
        best = c;
        for (r = c + 1; r < 4; r++)
            if (fabs(m[r][c]) > fabs(m[best][c])) best = r;
        if (!(fabs(m[best][c]) > 1e-30)) return 0;
        for (k = 0; k < 8; k++) {
            keep = m[best][k];
            m[best][k] = m[c][k];
            m[c][k] = keep;
        }
        for (k = 7; k >= c; k--) m[c][k] /= m[c][c];
        for (r = 0; r < 4; r++)
            for (k = 7; r != c && k >= c; k--) m[r][k] -= m[r][c] * m[c][k];
    }
    for (r = 0; r < 4; r++)
        for (c = 0; c < 4; c++) to[4 * c + r] = (float)m[r][4 + c];
    return 1;
}

/* One texture of the user's: there or not, of the right size and kind. */
static int glbk__gbuffer_takes(const glbk_context *ctx, const glbk_gbuffer *g, const char *field, const glbk_texture *t)
{
    const char *text = NULL;
    if (!t) return 1;
    if (!t->name || t->layers) text = "is no 2D texture";
    else if (t->width != g->width || t->height != g->height) text = "is of another size";
    if (text) glbk__gbuffer_bad(ctx, "glbk_gbuffer_import", field, text);
    return !text;
}

static int glbk__gbuffer_import_valid(const glbk_context *ctx, const glbk_gbuffer *g, const glbk_import *d)
{
    const char *const function = "glbk_gbuffer_import";
    if (!d->normals || (!d->depth && !d->positions)) {
        glbk__gbuffer_bad(ctx, function, "import", "needs normals, and depth or positions");
        return 0;
    }
    if (d->depth && !d->positions && glbk__gbuffer_is_zero(d->world_to_clip, 16)) {
        glbk__gbuffer_bad(ctx, function, "import.world_to_clip", "is needed for places by their depths");
        return 0;
    }
    return glbk__gbuffer_takes(ctx, g, "import.depth", d->depth) &&
           glbk__gbuffer_takes(ctx, g, "import.positions", d->positions) &&
           glbk__gbuffer_takes(ctx, g, "import.normals", d->normals) &&
           glbk__gbuffer_takes(ctx, g, "import.geometric", d->geometric) &&
           glbk__gbuffer_takes(ctx, g, "import.color_map", d->color_map) &&
           glbk__gbuffer_takes(ctx, g, "import.gloss_map", d->gloss_map) &&
           glbk__gbuffer_takes(ctx, g, "import.open_map", d->open_map) &&
           glbk__gbuffer_takes(ctx, g, "import.entities", d->entities) &&
           glbk__gbuffer_within(ctx, function, "import.clip_depth", d->clip_depth, 0, GLBK_CLIP_DEPTH_COUNT - 1) &&
           glbk__gbuffer_within(ctx, function, "import.normal_packing", d->normal_packing, 0,
                                GLBK_NORMAL_PACKING_COUNT - 1) &&
           glbk__gbuffer_material_valid(ctx, function, &d->material, d->plane, d->occlusion);
}

/* World to clip space in OpenGL's convention. */
static void glbk__gbuffer_clip(const glbk_import *d, float clip[16])
{
    const int reversed = d->clip_depth == GLBK_CLIP_DEPTH_REVERSED;
    int c;
    memcpy(clip, d->world_to_clip, sizeof d->world_to_clip);
    if (!reversed && d->clip_depth != GLBK_CLIP_DEPTH_ZERO_TO_ONE) return;
    for (c = 0; c < 4; c++)
        clip[4 * c + 2] = reversed ? clip[4 * c + 3] - 2 * clip[4 * c + 2] : 2 * clip[4 * c + 2] - clip[4 * c + 3];
}

static void glbk__gbuffer_fill_import(const glbk_gbuffer *g, const glbk_import *d, glbk_gbuffer_imported *v)
{
    const int reversed = d->clip_depth == GLBK_CLIP_DEPTH_REVERSED;
    const int half = !reversed && d->clip_depth != GLBK_CLIP_DEPTH_ZERO_TO_ONE;
    uint32_t *how = v->how;

    glbk__gbuffer_clip(d, v->to_clip);
    glbk__gbuffer_matrix(d->to_world, v->to_world);
    v->numbers[0] = glbk__gbuffer_kind(&d->material);
    v->numbers[1] = d->entity;
    v->numbers[2] = d->plane;
    v->lobes[0] = d->first_lobe;
    v->lobes[1] = d->material.lobe_count;
    how[0] = (d->positions ? (uint32_t)GLBK__IMPORT_PLACES : 0u) | (d->depth ? (uint32_t)GLBK__IMPORT_DEPTH : 0u) |
             (d->geometric ? (uint32_t)GLBK__IMPORT_FLAT : 0u) | (d->color_map ? (uint32_t)GLBK__IMPORT_COLORS : 0u) |
             (d->gloss_map ? (uint32_t)GLBK__IMPORT_GLOSS : 0u) | (d->open_map ? (uint32_t)GLBK__IMPORT_OPEN : 0u) |
             (d->entities ? (uint32_t)GLBK__IMPORT_ENTITIES : 0u) | (reversed ? (uint32_t)GLBK__IMPORT_REVERSED : 0u);
    how[1] = (uint32_t)d->normal_packing;
    how[2] = g->width;
    how[3] = g->height;
    memcpy(v->diffuse, d->material.diffuse, sizeof d->material.diffuse);
    glbk__gbuffer_gloss(&d->material, v->gloss);
    memcpy(v->eye, d->eye, sizeof d->eye);
    v->depths[0] = half ? 2.0f : 1.0f;
    v->depths[1] = half ? -1.0f : 0.0f;
    v->depths[2] = d->occlusion;
}

/* Texture objects that were not made here have no gl_target. */
static void glbk__gbuffer_bind_in(glbk_context *ctx, uint32_t slot, const glbk_texture *texture)
{
    glbk_texture t;
    memset(&t, 0, sizeof t);
    if (texture) t = *texture;
    t.gl_target = GLBK_GL_TEXTURE_2D;
    glbk_bind_texture(ctx, slot, &t);
}

static void glbk__gbuffer_bind_import(glbk_context *ctx, const glbk_import *d)
{
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_color_map, d->color_map);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_gloss_map, d->gloss_map);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_place_in, d->positions);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_depth_in, d->depth);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_normal_in, d->normals);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_flat_in, d->geometric);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_open_in, d->open_map);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_entity_in, d->entities);
}

GLBK_DEF glbk_result glbk_gbuffer_import(glbk_context *ctx, glbk_gbuffer *g, const glbk_import *d)
{
    glbk_gbuffer_imported values;
    glbk_result result = GLBK_OK;
    int own;

    if (!ctx || !g || !g->target.name || !d)
        return glbk__bad(ctx, GLBK_ERR_ARGUMENT, __func__, "gbuffer or import", "is NULL or was not created");
    if (!glbk__gbuffer_import_valid(ctx, g, d)) return GLBK_ERR_DESC;
    own = g->own_depth;
    memset(&values, 0, sizeof values);
    g->has_clip = !glbk__gbuffer_is_zero(d->world_to_clip, 16);
    if (g->has_clip && !glbk__gbuffer_invert(d->world_to_clip, values.from_clip))
        return glbk__gbuffer_bad(ctx, __func__, "import.world_to_clip", "has no inverse");
    glbk__gbuffer_fill_import(g, d, &values);
    if (!g->take.name)
        result = glbk_program_create(ctx, glbk_gbuffer_part(), "gbuffer_import.frag",
                                     own ? "GBUFFER_DEPTH=1" : "GBUFFER_DEPTH=0", &g->take);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_gbuffer_imported, &g->imported, &values);
    if (result == GLBK_OK)
        result = glbk__gbuffer_start(ctx, own ? &g->target : &g->colors, own ? GLBK_DEPTH_LESS : GLBK_DEPTH_OFF,
                                     &g->take);
    if (result != GLBK_OK) return result;
    glbk__gbuffer_bind_import(ctx, d);
    glbk_draw_screen(ctx);
    memcpy(g->clip, values.to_clip, sizeof g->clip);
    memcpy(g->eye, d->eye, sizeof g->eye);
    g->has_depth = own ? d->depth || g->has_clip : d->depth && d->depth->name == g->depth.name &&
                                                       d->clip_depth != GLBK_CLIP_DEPTH_REVERSED;
    return GLBK_OK;
}

/* ==== src/gl_gbuffer/end.h ==== */

#endif /* GL_GBUFFER_IMPLEMENTATION */

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
