/* gl_backend.h - v0.9.0 - what all gl_*.h share: a layer on OpenGL 3.3, ES 3.0, WebGL 2 - MIT-0 OR Unlicense

   What it does

   gl_csm.h, gl_shadowfield.h, gl_envshadow.h, gl_rsm.h and gl_ism.h bring the techniques onto the GPU:
   uploads as plain textures, GLSL functions to paste into your own shaders with a call that binds what they
   need, and complete passes. This is the small layer underneath, which they include and which you may use by
   itself: GL functions without a loader, textures, buffers, targets, passes, state. Programs with the
   techniques' GLSL are made by gl_programs.h, which they include as well.

   What it does not do

   - It makes no window and no context: make one (GLFW, EGL, SDL, Emscripten, ...) of OpenGL 3.3 core, ES 3.0
     or more, and make it current. The core path does without geometry shaders, texture buffers and compute;
     with 4.3 a compute path is used as well.
   - It must not be called inside an active transform feedback, a query of the same kind or a conditional
     rendering of yours.
   - It has no cache of GL state and assumes none: what it needs it sets, what it sets docs/gl-state.md lists.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #include "gl_backend/gl_backend.h"
       #include <stdio.h>
       #include <string.h>

       // With GLFW: return glfwGetProcAddress(name);  with EGL: return eglGetProcAddress(name);
       static glbk_proc_fn get_proc(const char *name, void *user)
       {
           (void)name; (void)user;
           return NULL;                                     // no GL here: init says so below
       }

       static void say(void *user, const char *message)
       {
           (void)user;
           printf("%s\n", message);
       }

       int main(void)
       {
           glbk_context gl;
           glbk_desc desc;
           glbk_result result;

           memset(&desc, 0, sizeof desc);
           desc.get_proc_fn = get_proc;                     // a context is current
           desc.system.log = say;
           result = glbk_init(&gl, &desc);
           if (result != GLBK_OK) {
               printf("no GL: %s\n", glbk_result_text(result));
               return result != GLBK_ERR_FUNCTION;
           }
           printf("GL %d on %s\n", gl.version, gl.renderer);
           glbk_free(&gl);
           return 0;
       }

   A picture drawn by a shader of your own that calls a function of the library: examples/06_csm_gl_minimal.c
   (07 to 10 do so with the other techniques). It needs csm.h, gl_backend/gl_csm.h and GLFW, and a display; on
   a machine without one start it by xvfb-run -a.

   Conventions

   Matrices are column-major float[16]; GL names are uint32_t; rows of textures go from the bottom up, as GL
   has them. Clip depth is GL's -1..1: passes set it back where a context has clip control.

     slot       number of a texture unit or uniform block counted from desc.first_unit or desc.first_block on;
                of a storage buffer or image, the number that GLSL gives it
     part       the GLSL of one header, and the slots of what it declares: see gl_programs.h
     target     a framebuffer object with the sizes and formats of what is attached
     pass       what GL must be set to before something is drawn

   How it works

   All GL functions come from your get_proc_fn and are kept in the context object: several contexts live side
   by side, no GL header and no link against GL is needed. What exists is decided by version and extension
   strings, not by whether get_proc_fn returns something.

   Floats on ES 3.0 and WebGL 2 are renderable with EXT_color_buffer_float only. Without it a target of format
   GLBK_FORMAT_COLOR holds the bits of floats in integers; ctx->float_targets says so, and lib/prelude.glsl of
   gl_programs.h hides the difference.

   Configuration

     GL_BACKEND_IMPLEMENTATION   in one source file: compiles the code
     GLBK_STATIC                 together with it, in each file that includes this header: a private copy, all
                                 functions static
     GLBK_DEF                    in each file that includes this header: your own linkage instead

   Memory, errors, threads, determinism

   Memory comes from the allocator in the desc, only in calls that say so; those of this header need none.
   Every function that can fail returns a glbk_result. If that is not GLBK_OK, its outputs are zeroed, GL
   objects made on the way are deleted, and desc.system.log gets the driver's words, the name of what is
   missing, or the field that is wrong with its value and its range. Without a context there is no log: calls
   with NULL for ctx, and glbk_init without a desc, return GLBK_ERR_ARGUMENT in silence. Calls that create,
   compile or read refuse to start while a GL error is pending (GLBK_ERR_PENDING), so that none of yours gets
   lost or blamed on us. Those of a frame (_update, _upload, _place, _object, _render, _shade, ...) do not ask
   for GL's error flag, which would wait for the driver: they return what they see by themselves. Call
   glbk_check once a frame, or set desc.check while you look for an error: then all of them ask, before and
   after. Creating, updating, reading and freeing leave every GL state as they found it; passes change what
   docs/gl-state.md lists, and glbk_state_save and glbk_state_restore bring it back. Every object is freed by
   its _free function, which accepts NULL, zeroed and half-made objects and, after glbk_abandon or
   GLBK_ERR_LOST, calls no GL. A context and its objects belong to the thread where the GL context is current.
   There are no globals.

   Cost: docs/measured/performance.md.  State: docs/gl-state.md.  History: CHANGELOG.md.
   Licence: end of this file. */
#ifndef GL_BACKEND_H
#define GL_BACKEND_H

#define GLBK_VERSION 900 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "gl_backend.h needs C99 or C++11"
#endif
#if defined(GLBK_STATIC) && !defined(GL_BACKEND_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_BACKEND_IMPLEMENTATION belongs into the same file"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef GLBK_DEF
#ifdef GLBK_STATIC
#define GLBK_DEF static inline
#else
#define GLBK_DEF extern
#endif
#endif
#define GLBK__DEF GLBK_DEF /* of functions that the headers gl_*.h share and that are not for you */

#if defined(_WIN32) && !defined(_WIN64)
#define GLBK_CALL __stdcall
#else
#define GLBK_CALL
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/gl/api_page_one.h ==== */

/* ---- page one: a context, and passes that draw ---- */

#define GLBK_RESULTS(X)                                                                                     \
    X(GLBK_OK, "ok")                                                                                        \
    X(GLBK_ERR_ARGUMENT, "a pointer is NULL, or a count or stride is out of range")                         \
    X(GLBK_ERR_DESC, "a field of a desc is out of range")                                                   \
    X(GLBK_ERR_INPUT, "the data cannot be used")                                                            \
    X(GLBK_ERR_ALLOC, "the allocator returned no memory")                                                   \
    X(GLBK_ERR_MEMORY, "the caller's memory is too small or misaligned")                                    \
    X(GLBK_ERR_LIMIT, "a size overflows or passes a limit")                                                 \
    X(GLBK_ERR_CANCELLED, "cancelled by the progress callback")                                             \
    X(GLBK_ERR_ORDER, "this call comes too early, too late or twice")                                       \
    X(GLBK_ERR_FORMAT, "not a file of this kind, or a damaged one")                                         \
    X(GLBK_ERR_VERSION, "a file of an unknown version")                                                     \
    X(GLBK_ERR_MISMATCH, "what was given does not belong together")                                         \
    X(GLBK_ERR_CONTEXT, "no GL context is current")                                                         \
    X(GLBK_ERR_OLD_CONTEXT, "the context is older than OpenGL 3.3 or OpenGL ES 3.0")                        \
    X(GLBK_ERR_FUNCTION, "a GL function is missing")                                                        \
    X(GLBK_ERR_FEATURE, "this call needs OpenGL 4.3 (compute)")                                             \
    X(GLBK_ERR_FLOAT_TARGET, "rendering to this float format needs EXT_color_buffer_float")                 \
    X(GLBK_ERR_NAME, "no GLSL file of that name")                                                           \
    X(GLBK_ERR_COMPILE, "a shader does not compile")                                                        \
    X(GLBK_ERR_LINK, "a program does not link")                                                             \
    X(GLBK_ERR_TARGET, "the driver cannot render to this combination of formats")                           \
    X(GLBK_ERR_GL_MEMORY, "GL is out of memory")                                                            \
    X(GLBK_ERR_GL, "GL reported an error")                                                                  \
    X(GLBK_ERR_PENDING, "a GL error from before this call was pending")                                     \
    X(GLBK_ERR_LOST, "the GL context is lost")

typedef enum glbk_result {
#define GLBK__ENUM(name, text) name,
    GLBK_RESULTS(GLBK__ENUM)
#undef GLBK__ENUM
    GLBK_RESULT_COUNT
} glbk_result;

typedef struct glbk_context glbk_context;   /* what a GL context can do, and GL's functions: "the context" */
struct glbk_desc;                   /* how the functions are found, and which units and bindings are ours */
struct glbk_pass;                   /* where a pass draws, and how */
struct glbk_program;                /* GL's name of a program; gl_programs.h compiles some */

GLBK_DEF glbk_result glbk_init(glbk_context *ctx, const struct glbk_desc *desc);
/* Loads GL's functions from the context that is current, decides what the context can do, and makes one empty
   vertex array and one small buffer.
   ctx      is yours, may be moved in memory afterwards, and is zeroed on errors
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. Without a desc there is no log either; GLBK_ERR_DESC;
            GLBK_ERR_CONTEXT; GLBK_ERR_OLD_CONTEXT; GLBK_ERR_FUNCTION: the log has its name; GLBK_ERR_LIMIT:
            first_unit or first_block reach beyond what the context has; GLBK_ERR_PENDING, GLBK_ERR_LOST,
            GLBK_ERR_GL, GLBK_ERR_GL_MEMORY */

GLBK_DEF glbk_result glbk_begin(glbk_context *ctx, const struct glbk_pass *pass,
                                struct glbk_program *program);
/* Begins a pass: sets every state that a draw depends on, so that nothing inherited shows, and binds the
   target, the program and the empty vertex array. Bind textures and blocks after it. docs/gl-state.md lists
   what is touched.
   program  the program to draw with; NULL if you make one the program in use yourself
   Errors   GLBK_ERR_ARGUMENT: ctx or pass is NULL; GLBK_ERR_DESC: a field of pass is out of range, the target
            was not created, or neither target nor viewport is given; GLBK_ERR_LOST. GL's error flag is not
            asked */

GLBK_DEF void glbk_draw_screen(glbk_context *ctx);
/* Draws one triangle over the whole viewport, after glbk_begin, from no attributes. */

GLBK_DEF glbk_result glbk_check(glbk_context *ctx);
/* Takes GL's error flag and returns it as a result, with its number in the log: GLBK_OK, GLBK_ERR_GL,
   GLBK_ERR_GL_MEMORY, or GLBK_ERR_LOST, which no call of a frame notices by itself. Passes and updates do not
   ask for the flag (unless desc.check is set), so call this once a frame; it makes drivers with threads of
   their own wait for what was asked of them. With desc.check it returns GLBK_ERR_ORDER while a technique's
   framebuffer is bound: what you drew since that technique's passes went into it. After such passes bind your
   own framebuffer, or put glbk_state_save and glbk_state_restore round them. */

GLBK_DEF void glbk_free(glbk_context *ctx);
/* Deletes what glbk_init made and zeroes ctx, which may be NULL. Free textures, buffers, targets and programs
   before: afterwards their _free functions call no GL. */

GLBK_DEF const char *glbk_result_text(glbk_result result);
/* Returns what a result means as a constant string, "unknown result" for a value beyond the list. */

/* ---- memory, log: the caller's ---- */

typedef void (*glbk_proc_fn)(void);
typedef glbk_proc_fn (*glbk_get_proc_fn)(const char *name, void *user);
/* Returns GL's function of that full name ("glBindTexture") or NULL. */

typedef struct glbk_allocator {     /* all zero = malloc and free; else both functions */
    void *(*alloc_fn)(size_t bytes, void *user);    /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} glbk_allocator;

typedef struct glbk_system {        /* all zero: malloc and free, no log */
    glbk_allocator allocator;       /* called from the thread that called us */
    void (*log)(void *user, const char *message);
    /* Called by a call that fails, from the thread that called us, before it returns: a text without a line
       end at its end that names the function, the field, its value and its range, or holds the driver's
       words, which may have several lines. It must call nothing of this library. */
    void *user;                     /* given to log */
} glbk_system;

/* ---- structs of page one ---- */

#define GLBK_UNITS 16u              /* slots of textures that a part has */
#define GLBK_MAX_UNITS 32u          /* slots of textures in a program with offsets, if the context has so many
                                       units; GL guarantees 16 for one shader stage */
#define GLBK_BLOCKS 8u              /* slots of uniform blocks, and of storage buffers, that a part has */
#define GLBK_MAX_BLOCKS 16u         /* slots of uniform blocks in a program with offsets */
#define GLBK_IMAGES 8u              /* slots of images, which are for compute shaders */
#define GLBK_MAX_PARTS 6u           /* parts that one program can use beside the base: gl_programs.h */

typedef struct glbk_desc {          /* zero it, then set what you care about */
    glbk_system    system;
    glbk_get_proc_fn get_proc_fn;   /* required */
    void          *user;            /* handed to get_proc_fn */
    int            core_only;       /* not 0: only what 3.3 and ES 3.0 share is used, even if the context has
                                       more */
    uint32_t       first_unit;      /* the 16 texture units from first_unit on are ours while we draw. A
                                       program with a glbk_offset also takes units after them, below
                                       first_unit + GLBK_MAX_UNITS */
    uint32_t       first_block;     /* the 8 bindings of uniform blocks from first_block on are ours, too. A
                                       program with a glbk_offset also takes bindings after them, below
                                       first_block + GLBK_MAX_BLOCKS. Storage buffers and images, which are
                                       for compute alone, are always at 0 .. 7, since GLSL says their
                                       numbers */
    int            check;           /* not 0, to look for errors, slowly: calls of a frame ask for GL's error
                                       flag, glbk_check and glbk_..._resolve look which framebuffer is
                                       bound, and glbk_envsh_maps_render draws twice, to find callbacks that
                                       do not draw all instances. Each of these says what it returns */
} glbk_desc;

typedef enum glbk_depth {           /* the depth test, and whether depth is written */
    GLBK_DEPTH_OFF,                 /* neither tested nor written */
    GLBK_DEPTH_LESS,
    GLBK_DEPTH_LESS_EQUAL,
    GLBK_DEPTH_EQUAL,               /* tested, not written */
    GLBK_DEPTH_GREATER,
    GLBK_DEPTH_COUNT
} glbk_depth;

typedef enum glbk_blend {
    GLBK_BLEND_OFF,
    GLBK_BLEND_ADD,
    GLBK_BLEND_MIN,
    GLBK_BLEND_MAX,
    GLBK_BLEND_OVER,                /* by source alpha */
    GLBK_BLEND_COUNT
} glbk_blend;

typedef enum glbk_cull { GLBK_CULL_OFF, GLBK_CULL_BACK, GLBK_CULL_FRONT, GLBK_CULL_COUNT } glbk_cull;

typedef struct glbk_pass {          /* if all but the target is zero, a draw overwrites everything */
    const struct glbk_target *target;   /* NULL = the framebuffer that is bound. Then the viewport must be
                                       given, and FRAMEBUFFER_SRGB stays as you have set it: no pass encodes
                                       colours by itself */
    int32_t            viewport[4]; /* x, y, width, height; all zero = the whole target */
    glbk_depth         depth;
    glbk_blend         blend;
    glbk_cull          cull;
    int                no_color;    /* not 0: writes depth only */
    float              offset[2];   /* of depth: factor and units of glPolygonOffset; both 0 = off */
} glbk_pass;

typedef struct glbk_offset {        /* where the slots of a part begin in a program that uses several parts */
    uint32_t unit, block;           /* added to the slots of its textures and of its uniform blocks */
} glbk_offset;

struct glbk_part;                   /* the GLSL of one header: gl_programs.h */

typedef struct glbk_program {       /* read only; zeroed = none. Of a program that you linked yourself set the
                                       name alone, or give glbk_begin NULL */
    uint32_t name;                  /* GL's */
    /* The rest is private. slots_fn gives textures and blocks their slots, and is NULL once it has. */
    void (*slots_fn)(const glbk_context *ctx, const struct glbk_program *program);
    const struct glbk_part *parts[GLBK_MAX_PARTS];
    glbk_offset offsets[GLBK_MAX_PARTS];
} glbk_program;

/* ==== src/gl/api_textures.h ==== */

/* ---- textures ---- */

typedef enum glbk_format {          /* both dialects know them all */
    GLBK_FORMAT_NONE,
    GLBK_FORMAT_COLOR,              /* RGBA32F; RGBA32UI with the bits of floats without ctx->float_targets */
    GLBK_FORMAT_R8, GLBK_FORMAT_RGBA8, GLBK_FORMAT_SRGB8_A8, GLBK_FORMAT_R8UI, GLBK_FORMAT_RGBA8UI,
    GLBK_FORMAT_R16UI, GLBK_FORMAT_RG16UI, GLBK_FORMAT_RGBA16UI,
    GLBK_FORMAT_R32UI, GLBK_FORMAT_RG32UI, GLBK_FORMAT_RGBA32UI,
    GLBK_FORMAT_R16F, GLBK_FORMAT_RGBA16F, GLBK_FORMAT_R32F, GLBK_FORMAT_RG32F, GLBK_FORMAT_RGBA32F,
    GLBK_FORMAT_DEPTH24, GLBK_FORMAT_DEPTH32F,
    GLBK_FORMAT_COUNT
} glbk_format;

typedef enum glbk_sampling {
    GLBK_SAMPLING_DEFAULT,          /* = GLBK_SAMPLING_NEAREST */
    GLBK_SAMPLING_NEAREST,
    GLBK_SAMPLING_LINEAR,           /* not for integers; 32-bit floats need ctx->float_linear */
    GLBK_SAMPLING_MIPMAPS,          /* linear, and between levels; they are generated on creation from data,
                                       those of floats where ctx->float_targets */
    GLBK_SAMPLING_COMPARE,          /* depth formats: linear comparison, sampler2DShadow */
    GLBK_SAMPLING_COUNT
} glbk_sampling;

typedef struct glbk_texture_desc {
    glbk_format   format;           /* required; GLBK_FORMAT_COLOR = GLBK_FORMAT_RGBA32F or RGBA32UI, see
                                       above */
    uint32_t      width, height;    /* 1 .. ctx->max_side */
    uint32_t      layers;           /* 0 = a 2D texture; else an array texture, 1 .. ctx->max_layers */
    uint32_t      levels;           /* 0 = 1, or all with GLBK_SAMPLING_MIPMAPS; at most down to 1 x 1 */
    glbk_sampling sampling;
    int           repeat;           /* not 0: wraps round; else clamps to the edge */
    const void   *data;             /* level 0, rows and layers without padding, or NULL = undefined texels */
} glbk_texture_desc;

typedef struct glbk_texture {       /* read only; zeroed = none */
    uint32_t    name;               /* GL's, for your own calls */
    uint32_t    gl_target;          /* GLBK_GL_TEXTURE_2D or GLBK_GL_TEXTURE_2D_ARRAY */
    glbk_format format;             /* GLBK_FORMAT_COLOR is resolved */
    uint32_t    width, height, layers, levels;
} glbk_texture;

GLBK_DEF glbk_result glbk_texture_create(glbk_context *ctx, const glbk_texture_desc *desc, glbk_texture *out);
/* Makes a texture with its sampling, and fills level 0 if desc.data is given. Mipmaps of a float format need
   ctx->float_targets.
   out      is zeroed on errors; free it with glbk_texture_free
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL; GLBK_ERR_DESC: a field is out of range; GLBK_ERR_LIMIT,
            for a size above ctx->max_side or max_layers;
            GLBK_ERR_FLOAT_TARGET, for mipmaps; GLBK_ERR_GL_MEMORY, GLBK_ERR_PENDING, GLBK_ERR_GL,
            GLBK_ERR_LOST. Every function below that creates, compiles or reads may return these last four;
            the other functions return GLBK_ERR_LOST alone of them, but all four if desc.check is set */

typedef struct glbk_box {           /* texels of one level of a texture */
    uint32_t level;
    uint32_t x, y;                  /* from the level's lower left corner on */
    uint32_t layer;                 /* the first one; 0 for a 2D texture */
    uint32_t width, height;         /* texels of that level */
    uint32_t layers;                /* 0 = 1 */
} glbk_box;

GLBK_DEF glbk_result glbk_texture_update(glbk_context *ctx, const glbk_texture *texture, const glbk_box *box,
                                         const void *data);
/* Overwrites a box of texels; other levels stay as they are, mipmaps too.
   box      must lie within the texture
   data     texels in the texture's format, rows and layers without padding; read during the call
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the box does not lie within the texture; GLBK_ERR_LOST */

GLBK_DEF void glbk_texture_free(glbk_context *ctx, glbk_texture *texture);
/* Deletes a texture and zeroes it. NULL and zeroed ones are allowed, here and in the other _free
   functions. */

/* ---- buffers: uniform blocks, vertices, and storage where ctx->compute ---- */

typedef struct glbk_buffer {        /* read only; zeroed = none */
    uint32_t name;
    size_t   bytes;
} glbk_buffer;

GLBK_DEF glbk_result glbk_buffer_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out);
/* Makes a buffer for any purpose but indices. It may serve several purposes, one after another.
   bytes    1 or more
   data     so many bytes, or NULL: the buffer's bytes are undefined then
   out      is zeroed on errors; free it with glbk_buffer_free
   Errors   GLBK_ERR_ARGUMENT: ctx or out is NULL, or bytes is 0; GLBK_ERR_LIMIT, for more bytes than
            PTRDIFF_MAX */

GLBK_DEF glbk_result glbk_indices_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out);
/* Makes a buffer for indices alone, as glbk_buffer_create does: WebGL allows indices in no buffer that was
   bound to anything else first. */

GLBK_DEF glbk_result glbk_buffer_update(glbk_context *ctx, const glbk_buffer *buffer, size_t offset,
                                        size_t bytes, const void *data);
/* Overwrites `bytes` bytes from byte `offset` on; the run must lie within the buffer. A whole buffer in one
   call costs least: it gets new storage, so that nothing waits for draws from the old.
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the run does not lie within the buffer; GLBK_ERR_LOST */

GLBK_DEF glbk_result glbk_buffer_read(glbk_context *ctx, const glbk_buffer *buffer, size_t offset,
                                      size_t bytes, void *out);
/* Copies `bytes` bytes from byte `offset` on to out; the run must lie within the buffer. The call waits until
   the GPU has done all its work, so the call is for tests and tools, not for frames.
   Errors   GLBK_ERR_ARGUMENT: as glbk_buffer_update; GLBK_ERR_FEATURE on ES and WebGL, which cannot read
            buffers */

GLBK_DEF void glbk_buffer_free(glbk_context *ctx, glbk_buffer *buffer);
/* Deletes a buffer and zeroes the struct. NULL and zeroed ones are allowed. */

/* ==== src/gl/api_targets.h ==== */

/* ---- targets ---- */

#define GLBK_MAX_ATTACHMENTS 4u     /* both dialects guarantee 4 */

typedef struct glbk_target_desc {
    const glbk_texture *color[GLBK_MAX_ATTACHMENTS];    /* from 0 on without gaps; all of one size */
    uint32_t            layer[GLBK_MAX_ATTACHMENTS];    /* of array textures */
    const glbk_texture *depth;      /* or NULL */
    uint32_t            depth_layer;
    uint32_t            level;      /* of all textures */
} glbk_target_desc;

typedef struct glbk_target {        /* read only; zeroed = none. The textures must outlive it */
    uint32_t    name;
    uint32_t    width, height, count;
    glbk_format format[GLBK_MAX_ATTACHMENTS];
    int         has_depth;
    int         inner;              /* private: a technique's */
} glbk_target;

GLBK_DEF glbk_result glbk_target_create(glbk_context *ctx, const glbk_target_desc *desc, glbk_target *out);
/* Makes a framebuffer of textures that you made. They must outlive it.
   out      is zeroed on errors; free it with glbk_target_free
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL; GLBK_ERR_DESC: there is no attachment, or a texture does not
            have that layer or level; GLBK_ERR_MISMATCH: sizes differ, or a depth texture stands for colours;
            GLBK_ERR_FLOAT_TARGET: floats without ctx->float_targets; GLBK_ERR_TARGET: the driver cannot draw
            to this combination */

GLBK_DEF glbk_result glbk_target_read(glbk_context *ctx, const glbk_target *target, uint32_t attachment,
                                      uint32_t x, uint32_t y, uint32_t width, uint32_t height, void *rgba);
/* Copies width x height pixels of a colour attachment from the GPU, from pixel (x, y) on, rows from the
   bottom up. The call waits until the GPU has done all its work.
   attachment   0 .. target->count - 1
   rgba         receives 16 bytes a pixel: four floats, or four uint32_t where the format has integers. Of a
                GLBK_FORMAT_COLOR target these are the floats in either case
   Errors       GLBK_ERR_ARGUMENT, also where the pixels do not lie within the target */

GLBK_DEF void glbk_target_free(glbk_context *ctx, glbk_target *target);
/* Deletes a framebuffer, not its textures, and zeroes the struct. NULL and zeroed ones are allowed. */

/* ==== src/gl/api_passes.h ==== */

/* ---- within a pass ---- */

GLBK_DEF void glbk_program_use(glbk_context *ctx, glbk_program *program);
/* Makes a program the one in use; the first time, its textures and blocks get their slots. glbk_begin and
   glbk_dispatch do this by themselves. If program is NULL or the context is lost, nothing happens. */

GLBK_DEF void glbk_clear(glbk_context *ctx, const glbk_target *target, uint32_t attachment,
                         const float rgba[4]);
/* Fills a colour attachment of the target that glbk_begin has bound, whatever the viewport. Integer formats
   get the numbers, rounded, within 0 and 2^32 - 1; GLBK_FORMAT_COLOR gets the floats. If an argument is NULL
   or attachment is not below target->count, nothing happens. */

GLBK_DEF void glbk_clear_depth(glbk_context *ctx, float depth);
/* Fills the depth of the target that glbk_begin has bound, in a pass whose depth mode writes. depth is 0
   (near) .. 1 (far). */

GLBK_DEF void glbk_bind_texture(glbk_context *ctx, uint32_t slot, const glbk_texture *texture);
/* Binds a texture to a slot for the draws and dispatches that follow, without a sampler object.
   slot      GLBK_SLOT_name of the texture, plus its part's offset, counted from ctx->first_unit on. With a
             slot beyond GLBK_MAX_UNITS or the context's last unit nothing happens: bind textures of your own
             there yourself
   texture   NULL or not created: the unit gets no texture, for a sampler that is declared and not read. A
             texture that others left there may be of another kind than the sampler, and WebGL then refuses to
             draw */

GLBK_DEF void glbk_bind_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer);
/* Binds a whole buffer as the uniform block of a slot, GLBK_SLOT_name plus its part's offset, counted from
   ctx->first_block on. With a slot beyond the context's last binding, or NULL, nothing happens. */

GLBK_DEF void glbk_bind_storage(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer);
/* Binds a whole buffer as the storage buffer of a slot, 0 .. 7, for compute shaders. Without ctx->compute
   nothing happens. */

GLBK_DEF void glbk_bind_image(glbk_context *ctx, uint32_t slot, const glbk_texture *texture);
/* Binds level 0 of a texture, all layers, to an image slot, 0 .. 7, which compute shaders read and write.
   Without ctx->compute nothing happens. The shader's layout must name the texture's format: rgba32f for
   GLBK_FORMAT_COLOR. GL has no images of sRGB and of depth. */

/* ---- state ---- */

typedef struct glbk_state {         /* private: what glbk_begin and the binding calls may change */
    uint8_t  caps[32], blend[8];
    uint8_t  color_mask[8][4], depth_mask;
    int32_t  words[24];
    int32_t  viewport[4];
    float    floats[4];
    int32_t  units[GLBK_MAX_UNITS][3];
    int32_t  blocks[GLBK_MAX_BLOCKS], storage[GLBK_BLOCKS];
    int64_t  ranges[GLBK_MAX_BLOCKS][2], storage_ranges[GLBK_BLOCKS][2];
    int32_t  images[GLBK_IMAGES][6];
    int32_t  blends[8][6];
    float    offset_clamp;
} glbk_state;

GLBK_DEF void glbk_state_save(glbk_context *ctx, glbk_state *out);
/* Keeps every state that passes and binding calls may change, docs/gl-state.md, for glbk_state_restore. Call
   both round a pass or a whole frame of them where the rest of your renderer relies on its state. The call
   asks GL some hundred questions, for each of which drivers with threads of their own wait. */

GLBK_DEF void glbk_state_restore(glbk_context *ctx, const glbk_state *state);
/* Sets again what glbk_state_save has kept. What was bound must not be deleted in between; a program that you
   had deleted while it was in use is gone (0) afterwards, as GL says. */

/* ==== src/gl/gl_functions.h ==== */

/* ---- GL itself: functions without the gl prefix, constants ----

   X(group, return type, name, types of the parameters, in the order that GL's reference gives them). Groups:
   CORE is in OpenGL 3.3 and ES 3.0 alike; DESK in OpenGL 3.3 only, ES in ES only; TARGETS in OpenGL 3.3 and
   ES 3.2, BLENDS in OpenGL 4.0 and ES 3.2, COMPUTE in OpenGL 4.3: NULL where the context is older. */

#define GLBK__QUERY_FUNCTIONS(X) \
    X(CORE, const uint8_t *, GetString, (uint32_t)) \
    X(CORE, const uint8_t *, GetStringi, (uint32_t, uint32_t)) X(CORE, uint32_t, GetError, (void)) \
    X(CORE, void, GetIntegerv, (uint32_t, int32_t *)) X(CORE, void, GetFloatv, (uint32_t, float *)) \
    X(CORE, void, GetBooleanv, (uint32_t, uint8_t *)) \
    X(CORE, void, GetIntegeri_v, (uint32_t, uint32_t, int32_t *)) \
    X(CORE, void, GetInteger64i_v, (uint32_t, uint32_t, int64_t *)) \
    X(CORE, uint8_t, IsEnabled, (uint32_t))
#define GLBK__STATE_FUNCTIONS(X) \
    X(CORE, void, Enable, (uint32_t)) X(CORE, void, Disable, (uint32_t)) \
    X(CORE, void, Viewport, (int32_t, int32_t, int32_t, int32_t)) \
    X(CORE, void, Scissor, (int32_t, int32_t, int32_t, int32_t)) \
    X(CORE, void, ColorMask, (uint8_t, uint8_t, uint8_t, uint8_t)) X(CORE, void, DepthMask, (uint8_t)) \
    X(CORE, void, DepthFunc, (uint32_t)) X(CORE, void, CullFace, (uint32_t)) \
    X(CORE, void, FrontFace, (uint32_t)) X(CORE, void, PolygonOffset, (float, float)) \
    X(CORE, void, BlendEquationSeparate, (uint32_t, uint32_t)) \
    X(CORE, void, BlendFuncSeparate, (uint32_t, uint32_t, uint32_t, uint32_t))
#define GLBK__CLEAR_FUNCTIONS(X) \
    X(CORE, void, ClearBufferfv, (uint32_t, int32_t, const float *)) \
    X(CORE, void, ClearBufferuiv, (uint32_t, int32_t, const uint32_t *)) \
    X(CORE, void, PixelStorei, (uint32_t, int32_t)) \
    X(CORE, void, ReadPixels, (int32_t, int32_t, int32_t, int32_t, uint32_t, uint32_t, void *))
#define GLBK__TEXTURE_FUNCTIONS(X) \
    X(CORE, void, ActiveTexture, (uint32_t)) X(CORE, void, GenTextures, (int32_t, uint32_t *)) \
    X(CORE, void, DeleteTextures, (int32_t, const uint32_t *)) \
    X(CORE, void, BindTexture, (uint32_t, uint32_t)) X(CORE, void, BindSampler, (uint32_t, uint32_t)) \
    X(CORE, void, TexParameteri, (uint32_t, uint32_t, int32_t)) X(CORE, void, GenerateMipmap, (uint32_t))
#define GLBK__IMAGE_FUNCTIONS(X) \
    X(CORE, void, TexImage2D, (uint32_t, int32_t, int32_t, int32_t, int32_t, int32_t, uint32_t, \
                               uint32_t, const void *)) \
    X(CORE, void, TexImage3D, (uint32_t, int32_t, int32_t, int32_t, int32_t, int32_t, int32_t, \
                               uint32_t, uint32_t, const void *)) \
    X(CORE, void, TexSubImage2D, (uint32_t, int32_t, int32_t, int32_t, int32_t, int32_t, uint32_t, \
                                  uint32_t, const void *)) \
    X(CORE, void, TexSubImage3D, (uint32_t, int32_t, int32_t, int32_t, int32_t, int32_t, int32_t, \
                                  int32_t, uint32_t, uint32_t, const void *))
#define GLBK__TARGET_FUNCTIONS(X) \
    X(CORE, void, GenFramebuffers, (int32_t, uint32_t *)) \
    X(CORE, void, DeleteFramebuffers, (int32_t, const uint32_t *)) \
    X(CORE, void, BindFramebuffer, (uint32_t, uint32_t)) \
    X(CORE, void, FramebufferTexture2D, (uint32_t, uint32_t, uint32_t, uint32_t, int32_t)) \
    X(CORE, void, FramebufferTextureLayer, (uint32_t, uint32_t, uint32_t, int32_t, int32_t)) \
    X(CORE, uint32_t, CheckFramebufferStatus, (uint32_t)) \
    X(CORE, void, DrawBuffers, (int32_t, const uint32_t *)) X(CORE, void, ReadBuffer, (uint32_t))
#define GLBK__BUFFER_FUNCTIONS(X) \
    X(CORE, void, GenBuffers, (int32_t, uint32_t *)) \
    X(CORE, void, DeleteBuffers, (int32_t, const uint32_t *)) \
    X(CORE, void, BindBuffer, (uint32_t, uint32_t)) \
    X(CORE, void, BindBufferBase, (uint32_t, uint32_t, uint32_t)) \
    X(CORE, void, BindBufferRange, (uint32_t, uint32_t, uint32_t, ptrdiff_t, ptrdiff_t)) \
    X(CORE, void, BufferData, (uint32_t, ptrdiff_t, const void *, uint32_t)) \
    X(CORE, void, BufferSubData, (uint32_t, ptrdiff_t, ptrdiff_t, const void *)) \
    X(CORE, void, GenVertexArrays, (int32_t, uint32_t *)) \
    X(CORE, void, DeleteVertexArrays, (int32_t, const uint32_t *))
#define GLBK__DRAW_FUNCTIONS(X) \
    X(CORE, void, BindVertexArray, (uint32_t)) X(CORE, void, EnableVertexAttribArray, (uint32_t)) \
    X(CORE, void, VertexAttribPointer, (uint32_t, int32_t, uint32_t, uint8_t, int32_t, const void *)) \
    X(CORE, void, DrawArrays, (uint32_t, int32_t, int32_t)) \
    X(CORE, void, DrawElements, (uint32_t, int32_t, uint32_t, const void *)) \
    X(CORE, void, DrawArraysInstanced, (uint32_t, int32_t, int32_t, int32_t)) \
    X(CORE, void, DrawElementsInstanced, (uint32_t, int32_t, uint32_t, const void *, int32_t))
#define GLBK__SHADER_FUNCTIONS(X) \
    X(CORE, uint32_t, CreateShader, (uint32_t)) \
    X(CORE, void, ShaderSource, (uint32_t, int32_t, const char *const *, const int32_t *)) \
    X(CORE, void, CompileShader, (uint32_t)) X(CORE, void, GetShaderiv, (uint32_t, uint32_t, int32_t *)) \
    X(CORE, void, GetShaderInfoLog, (uint32_t, int32_t, int32_t *, char *)) \
    X(CORE, void, DeleteShader, (uint32_t))
#define GLBK__PROGRAM_FUNCTIONS(X) \
    X(CORE, uint32_t, CreateProgram, (void)) X(CORE, void, AttachShader, (uint32_t, uint32_t)) \
    X(CORE, void, TransformFeedbackVaryings, (uint32_t, int32_t, const char *const *, uint32_t)) \
    X(CORE, void, LinkProgram, (uint32_t)) X(CORE, void, GetProgramiv, (uint32_t, uint32_t, int32_t *)) \
    X(CORE, void, GetProgramInfoLog, (uint32_t, int32_t, int32_t *, char *)) \
    X(CORE, void, DeleteProgram, (uint32_t)) X(CORE, uint8_t, IsProgram, (uint32_t)) \
    X(CORE, void, UseProgram, (uint32_t))
#define GLBK__UNIFORM_FUNCTIONS(X) \
    X(CORE, int32_t, GetUniformLocation, (uint32_t, const char *)) \
    X(CORE, uint32_t, GetUniformBlockIndex, (uint32_t, const char *)) \
    X(CORE, void, UniformBlockBinding, (uint32_t, uint32_t, uint32_t)) \
    X(CORE, void, GetActiveUniform, (uint32_t, uint32_t, int32_t, int32_t *, int32_t *, uint32_t *, char *)) \
    X(CORE, void, GetActiveUniformBlockName, (uint32_t, uint32_t, int32_t, int32_t *, char *)) \
    X(CORE, void, GetActiveUniformBlockiv, (uint32_t, uint32_t, uint32_t, int32_t *)) \
    X(CORE, void, GetUniformiv, (uint32_t, int32_t, int32_t *)) \
    X(CORE, void, Uniform1i, (int32_t, int32_t)) X(CORE, void, Uniform1f, (int32_t, float)) \
    X(CORE, void, Uniform4fv, (int32_t, int32_t, const float *)) \
    X(CORE, void, UniformMatrix4fv, (int32_t, int32_t, uint8_t, const float *))
#define GLBK__FEEDBACK_FUNCTIONS(X) \
    X(CORE, void, BeginTransformFeedback, (uint32_t)) X(CORE, void, EndTransformFeedback, (void)) \
    X(CORE, void, Finish, (void))
#define GLBK__ONE_DIALECT_FUNCTIONS(X) \
    X(ES, void, DepthRangef, (float, float)) \
    X(ES, void, TexStorage2D, (uint32_t, int32_t, uint32_t, int32_t, int32_t)) \
    X(ES, void, TexStorage3D, (uint32_t, int32_t, uint32_t, int32_t, int32_t, int32_t)) \
    X(DESK, void, DepthRange, (double, double)) X(DESK, void, PolygonMode, (uint32_t, uint32_t)) \
    X(DESK, void, PointSize, (float)) X(DESK, void, ClampColor, (uint32_t, uint32_t))
#define GLBK__LATER_FUNCTIONS(X) \
    X(TARGETS, void, ColorMaski, (uint32_t, uint8_t, uint8_t, uint8_t, uint8_t)) \
    X(TARGETS, void, GetBooleani_v, (uint32_t, uint32_t, uint8_t *)) \
    X(TARGETS, void, Enablei, (uint32_t, uint32_t)) X(TARGETS, void, Disablei, (uint32_t, uint32_t)) \
    X(TARGETS, uint8_t, IsEnabledi, (uint32_t, uint32_t)) \
    X(BLENDS, void, BlendEquationSeparatei, (uint32_t, uint32_t, uint32_t)) \
    X(BLENDS, void, BlendFuncSeparatei, (uint32_t, uint32_t, uint32_t, uint32_t, uint32_t)) \
    X(DESK, void, GetBufferSubData, (uint32_t, ptrdiff_t, ptrdiff_t, void *))
#define GLBK__COMPUTE_FUNCTIONS(X) \
    X(COMPUTE, void, DispatchCompute, (uint32_t, uint32_t, uint32_t)) \
    X(COMPUTE, void, DispatchComputeIndirect, (ptrdiff_t)) \
    X(COMPUTE, uint32_t, GetProgramResourceIndex, (uint32_t, uint32_t, const char *)) \
    X(COMPUTE, void, BindImageTexture, (uint32_t, uint32_t, int32_t, uint8_t, int32_t, uint32_t, \
                                        uint32_t)) \
    X(COMPUTE, void, Barrier, (uint32_t)) /* glMemoryBarrier: windows.h has a macro of that name */ \
    X(CLIP, void, ClipControl, (uint32_t, uint32_t)) /* 4.5 or an extension, of ES too */ \
    X(CLAMP, void, PolygonOffsetClamp, (float, float, float)) /* 4.6 or an extension */
#define GLBK_FUNCTIONS(X) \
    GLBK__QUERY_FUNCTIONS(X) GLBK__STATE_FUNCTIONS(X) GLBK__CLEAR_FUNCTIONS(X) GLBK__TEXTURE_FUNCTIONS(X) \
    GLBK__IMAGE_FUNCTIONS(X) GLBK__TARGET_FUNCTIONS(X) GLBK__BUFFER_FUNCTIONS(X) GLBK__DRAW_FUNCTIONS(X) \
    GLBK__SHADER_FUNCTIONS(X) GLBK__PROGRAM_FUNCTIONS(X) GLBK__UNIFORM_FUNCTIONS(X) \
    GLBK__FEEDBACK_FUNCTIONS(X) GLBK__ONE_DIALECT_FUNCTIONS(X) GLBK__LATER_FUNCTIONS(X) \
    GLBK__COMPUTE_FUNCTIONS(X)

typedef struct glbk_functions {
#define GLBK__FIELD(group, type, name, parameters) type(GLBK_CALL *name) parameters;
    GLBK_FUNCTIONS(GLBK__FIELD)
#undef GLBK__FIELD
} glbk_functions;

/* The constants of GL that the sections below and most users need. */
enum {
    GLBK_GL_TRIANGLES = 0x0004, GLBK_GL_TRIANGLE_STRIP = 0x0005, GLBK_GL_POINTS = 0x0000,
    GLBK_GL_LINES = 0x0001, GLBK_GL_BYTE = 0x1400, GLBK_GL_UNSIGNED_BYTE = 0x1401,
    GLBK_GL_UNSIGNED_SHORT = 0x1403, GLBK_GL_INT = 0x1404, GLBK_GL_UNSIGNED_INT = 0x1405,
    GLBK_GL_FLOAT = 0x1406, GLBK_GL_HALF_FLOAT = 0x140B, GLBK_GL_COLOR = 0x1800, GLBK_GL_DEPTH = 0x1801,
    GLBK_GL_TEXTURE_2D = 0x0DE1, GLBK_GL_TEXTURE_2D_ARRAY = 0x8C1A,
    GLBK_GL_TEXTURE_CUBE_MAP = 0x8513, GLBK_GL_TEXTURE0 = 0x84C0,
    GLBK_GL_FRAMEBUFFER = 0x8D40, GLBK_GL_READ_FRAMEBUFFER = 0x8CA8, GLBK_GL_DRAW_FRAMEBUFFER = 0x8CA9,
    GLBK_GL_COLOR_ATTACHMENT0 = 0x8CE0, GLBK_GL_DEPTH_ATTACHMENT = 0x8D00, GLBK_GL_ARRAY_BUFFER = 0x8892,
    GLBK_GL_ELEMENT_ARRAY_BUFFER = 0x8893, GLBK_GL_UNIFORM_BUFFER = 0x8A11,
    GLBK_GL_SHADER_STORAGE_BUFFER = 0x90D2, GLBK_GL_COPY_WRITE_BUFFER = 0x8F37,
    GLBK_GL_TRANSFORM_FEEDBACK_BUFFER = 0x8C8E, GLBK_GL_INTERLEAVED_ATTRIBS = 0x8C8C,
    GLBK_GL_RASTERIZER_DISCARD = 0x8C89, GLBK_GL_STATIC_DRAW = 0x88E4, GLBK_GL_STREAM_DRAW = 0x88E0,
    GLBK_GL_ANY_SAMPLES_PASSED = 0x8C2F, GLBK_GL_QUERY_RESULT = 0x8866,
    GLBK_GL_DISPATCH_INDIRECT_BUFFER = 0x90EE
};
#define GLBK_GL_ALL_BARRIER_BITS 0xFFFFFFFFu

/* ==== src/gl/api_context.h ==== */

/* ---- the context ---- */

struct glbk_context {               /* read only; the fields after max_point_side are private */
    glbk_functions gl;              /* gl.BindTexture(...): yours to call, too */
    uint32_t       program;         /* GL's name of the program that glbk_begin bound last, for uniforms of
                                       functions of yours */
    const char    *renderer;        /* the driver's name, valid while the GL context lives */
    int            es;              /* not 0: OpenGL ES or WebGL */
    int            webgl;           /* not 0: WebGL, which always restarts primitives, without a switch */
    uint32_t       version;         /* 330 .. 460, or 300 .. 320 with es */
    int            compute;         /* not 0: OpenGL 4.3, compute shaders and storage buffers */
    int            float_targets;   /* not 0: RGBA32F and the other formats of floats are renderable */
    int            float_blend;     /* not 0: these can be blended into */
    int            float_linear;    /* not 0: 32-bit float textures can be filtered */
    int            clip_control;    /* not 0: glClipControl is there */
    uint32_t       max_side;        /* texels a side of a 2D texture */
    uint32_t       max_layers;      /* layers of an array texture */
    uint32_t       max_targets;     /* colour attachments that can be drawn to at once */
    float          max_point_side;  /* pixels a side of a point */
    uint32_t       vertex_array;    /* empty, for passes that need no attributes */
    uint32_t       shown;           /* buffer of the block glbk_shown of gl_gbuffer.h */
    int            lost;            /* not 0: no call reaches GL any more */
    glbk_system    system;
    uint32_t       first_unit, first_block;
    uint32_t       unit_count, block_count;     /* that the context has from those on, at most
                                                   GLBK_MAX_UNITS and GLBK_MAX_BLOCKS */
    int            each_target;     /* not 0: colour mask and blending are switched for each target */
    int            each_blend;      /* not 0: each target has blend functions of its own */
    int            offset_clamp;    /* not 0: glPolygonOffsetClamp is there */
    int            check;           /* desc.check */
    uint32_t       inner;           /* the framebuffer that glbk_begin bound last, if it is a technique's */
    size_t         max_storage;     /* bytes of a storage buffer */
};

GLBK_DEF void glbk_abandon(glbk_context *ctx);
/* Says that the GL context is gone or not current: from now on the _free functions touch memory only, and all
   other calls return GLBK_ERR_LOST or do nothing. Call it if your window system reports a lost context, then
   free everything, glbk_free the context last, and begin anew with glbk_init. ctx may be NULL. */

/* ==== src/gl/inside.h ==== */

/* ---- for the techniques' headers: not for you, may change without notice ----

   Their implementations may stand in other files than this header's, hence no static functions: GLBK__DEF is
   GLBK_DEF for them. */

/* Every call that can fail and calls GL begins with glbk__enter, which returns GLBK_ERR_ARGUMENT for no
   context, GLBK_ERR_LOST, or GLBK_ERR_PENDING, and ends with glbk__leave, which returns the errors that GL
   has kept since. A call of a frame begins with glbk__enter_frame and ends with glbk__leave_frame, which ask
   GL with desc.check alone. A creating call begins with glbk__enter_create, which zeroes the `bytes` bytes of
   its output and refuses NULL; glbk__leave_created ends one whose last steps were those of a frame: if result
   is GLBK_OK it asks GL. */
GLBK__DEF glbk_result glbk__enter(glbk_context *ctx);
GLBK__DEF glbk_result glbk__enter_frame(glbk_context *ctx);
GLBK__DEF glbk_result glbk__enter_create(glbk_context *ctx, const char *function, void *out, size_t bytes);
GLBK__DEF glbk_result glbk__leave(glbk_context *ctx);
GLBK__DEF glbk_result glbk__leave_frame(glbk_context *ctx);
GLBK__DEF glbk_result glbk__leave_created(glbk_context *ctx, glbk_result result);

/* These three log why a call fails and return the result: "FUNCTION: FIELD TEXT"; "FUNCTION: FIELD is VALUE;
   it must be WANTED"; "FUNCTION: FIELD is VALUE; it must be LOW..HIGH". function is __func__ of the public
   function. */
GLBK__DEF glbk_result glbk__refuse(const glbk_context *ctx, glbk_result result, const char *function,
                                   const char *field, const char *text);
GLBK__DEF glbk_result glbk__refuse_value(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *field, double value, const char *wanted);
GLBK__DEF glbk_result glbk__refuse_range(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *field, double value, double low, double high);
/* glbk__target_create makes a target of a technique's own as glbk_target_create does. Nobody else may draw to
   such a target; glbk_check looks whether somebody does. glbk__attach attaches a texture to the framebuffer
   that is bound; if the texture is NULL it does nothing. */
GLBK__DEF glbk_result glbk__target_create(glbk_context *ctx, const glbk_target_desc *desc, glbk_target *out);
GLBK__DEF void glbk__attach(const glbk_context *ctx, uint32_t attachment, const glbk_texture *t,
                            uint32_t level, uint32_t layer);

/* With desc.check, returns GLBK_ERR_ORDER and logs it while a technique's framebuffer is bound. */
GLBK__DEF glbk_result glbk__check_bound(const glbk_context *ctx, const char *function);

/* Enables or disables a capability, the name that glEnable takes. */
GLBK__DEF void glbk__set_cap(const glbk_context *ctx, uint32_t name, int on);

/* Returns a whole number that GL keeps under this name, the first one if there are several. */
GLBK__DEF uint32_t glbk__get_integer(const glbk_context *ctx, uint32_t name);

/* GL's bindings and parameters of texels in memory that an upload replaces and puts back. Several boxes may
   be uploaded between glbk__upload_begin and glbk__upload_end; they are not checked. */
typedef struct glbk__store {
    int32_t value[8], buffer;
} glbk__store;
typedef struct glbk__upload {
    glbk__store store;
    int32_t     bound;
} glbk__upload;
GLBK__DEF void glbk__upload_begin(const glbk_context *ctx, const glbk_texture *t, glbk__upload *old);
GLBK__DEF void glbk__upload_box(const glbk_context *ctx, const glbk_texture *t, const glbk_box *b,
                                const void *data);
GLBK__DEF void glbk__upload_end(const glbk_context *ctx, const glbk_texture *t, const glbk__upload *old);

/* Returns the bytes of a texel in memory. */
GLBK__DEF uint32_t glbk__texel_bytes(glbk_format format);

/* ==== src/gl/begin.h ==== */

/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_BACKEND_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_BACKEND_IMPLEMENTATION) && !defined(GL_BACKEND_IMPLEMENTED)
#define GL_BACKEND_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== src/shared/mem.h ==== */

/* unit mem: checked sizes, and the caller's allocator with malloc and free as its default */

/* Returns 1 if the functions of a public allocator are both there or both NULL. */
static inline int glbk__allocator_valid(void *(*alloc_fn)(size_t, void *), void (*free_fn)(void *, void *))
{
    return (alloc_fn == NULL) == (free_fn == NULL);
}

/* ==== src/shared/message.h ==== */

/* unit message: one line for the caller's log that says why a call failed */

/* GLBK__COLD stands before functions that are needed only by calls that fail: compilers make these functions
   small, and take branches to them for unlikely. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define GLBK__COLD __attribute__((cold))
#else
#define GLBK__COLD
#endif

/* Where a message goes, and the name of the function that failed. If log is NULL, nothing is written. */
typedef struct glbk__logger {
    void (*log)(void *user, const char *message);
    void *user;
    const char *function;
} glbk__logger;

typedef struct glbk__message { char text[256]; size_t used; } glbk__message;

/* Appends a text; what does not fit is cut off. */
static inline GLBK__COLD void glbk__message_text(glbk__message *m, const char *s)
{
    while (*s && m->used + 1 < sizeof m->text) m->text[m->used++] = *s++;
    m->text[m->used] = 0;
}

static inline GLBK__COLD void glbk__message_count(glbk__message *m, uint64_t value)
{
    char digits[24];
    size_t at = sizeof digits - 1;
    digits[at] = 0;
    do digits[--at] = (char)('0' + (int)(value % 10));
    while ((value /= 10) != 0);
    glbk__message_text(m, digits + at);
}

/* Writes six significant digits without the zeros at their end. Returns how many digits are left and writes
   *exponent, the power of ten of the first one. value is finite and above 0. */
static inline GLBK__COLD int glbk__message_digits(double value, char digits[8], int *exponent)
{
    uint32_t whole;
    int count = 6, i;

    for (*exponent = 5; value >= 999999.5; value /= 10.0) ++*exponent;
    for (; value < 99999.95; value *= 10.0) --*exponent;
    whole = (uint32_t)(value + 0.5);
    if (whole > 999999) {
        whole = 100000;
        ++*exponent;
    }
    for (; count > 1 && whole % 10 == 0; count--) whole /= 10;
    for (i = count; i > 0; whole /= 10) digits[--i] = (char)('0' + (int)(whole % 10));
    digits[count] = 0;
    return count;
}

/* Appends a number, in the same way in every locale: whole numbers below 2^53 with all their digits, others
   with six, as in 0.25, -3, 1.5e-7. */
static inline GLBK__COLD void glbk__message_number(glbk__message *m, double value)
{
    char digits[8], first[2] = { 0, 0 };
    int exponent, count, i;

    if (value != value) {
        glbk__message_text(m, "not a number");
        return;
    }
    if (value < 0.0) glbk__message_text(m, "-");
    if (value < 0.0) value = -value;
    if (!(value > 0.0) || value > 1.7976931348623157e308) {
        glbk__message_text(m, value > 0.0 ? "infinity" : "0");
        return;
    }
    if (value < 9007199254740992.0 && value - (double)(uint64_t)value <= 0.0) {
        glbk__message_count(m, (uint64_t)value);
        return;
    }
    count = glbk__message_digits(value, digits, &exponent);
    first[0] = digits[0];
    if (exponent < -4 || exponent > 9) {
        glbk__message_text(m, first);
        if (count > 1) glbk__message_text(m, ".");
        glbk__message_text(m, digits + 1);
        glbk__message_text(m, exponent < 0 ? "e-" : "e");
        glbk__message_count(m, (uint64_t)(exponent < 0 ? -exponent : exponent));
        return;
    }
    if (exponent < 0) glbk__message_text(m, "0.");
    for (i = exponent; i < -1; i++) glbk__message_text(m, "0");
    for (i = 0; i < count; i++) {
        if (exponent >= 0 && i == exponent + 1) glbk__message_text(m, ".");
        first[0] = digits[i];
        glbk__message_text(m, first);
    }
    for (i = count; i <= exponent; i++) glbk__message_text(m, "0");
}

/* Begins a line: "FUNCTION: FIELD". */
static inline GLBK__COLD void glbk__message_begin(glbk__message *m,
                                          const glbk__logger *logger, const char *field)
{
    m->used = 0;
    glbk__message_text(m, logger->function);
    glbk__message_text(m, ": ");
    glbk__message_text(m, field);
}

/* Logs "FUNCTION: FIELD TEXT", as in "cohsm_build: mesh.positions is NULL". */
static inline GLBK__COLD void glbk__log_text(const glbk__logger *logger, const char *field, const char *text)
{
    glbk__message m;
    if (!logger->log) return;
    glbk__message_begin(&m, logger, field);
    glbk__message_text(&m, " ");
    glbk__message_text(&m, text);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: FIELD is VALUE; it must be WANTED", as in "cohsm_build: desc.map_side is 3; it must be 0 or
   4..1024". */
static inline GLBK__COLD void glbk__log_value(const glbk__logger *logger, const char *field, double value,
                                      const char *wanted)
{
    glbk__message m;
    if (!logger->log) return;
    glbk__message_begin(&m, logger, field);
    glbk__message_text(&m, " is ");
    glbk__message_number(&m, value);
    glbk__message_text(&m, "; it must be ");
    glbk__message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* ==== src/gl/log.h ==== */

/* ---- log: why a call fails ---- */

GLBK_DEF const char *glbk_result_text(glbk_result result)
{
#define GLBK__TEXT(name, text) text "\0"
    const char *s = GLBK_RESULTS(GLBK__TEXT) "unknown result";
#undef GLBK__TEXT
    unsigned i;
    for (i = 0; i < (unsigned)result && i < GLBK_RESULT_COUNT; i++) s += strlen(s) + 1;
    return s;
}

static void glbk__log(const glbk_context *ctx, const char *text)
{
    if (ctx->system.log) ctx->system.log(ctx->system.user, text);
}

/* Logs a text, then a name, and returns the result. */
static glbk_result glbk__fail(const glbk_context *ctx, glbk_result result, const char *text, const char *name)
{
    glbk__message m;
    m.used = 0;
    glbk__message_text(&m, text);
    glbk__message_text(&m, name);
    glbk__log(ctx, m.text);
    return result;
}

/* Logs "TEXT 0x0502": hexadecimal with at least four digits, as GL's constants are known. */
static void glbk__log_constant(const glbk_context *ctx, const char *text, uint32_t value)
{
    char digits[16] = { 0 };
    int at = 15;
    while (value || at > 11) {
        digits[--at] = "0123456789abcdef"[value % 16];
        value /= 16;
    }
    digits[--at] = 'x';
    digits[--at] = '0';
    (void)glbk__fail(ctx, GLBK_ERR_GL, text, digits + at);
}

static glbk__logger glbk__logger_of(const glbk_context *ctx, const char *function)
{
    glbk__logger logger;
    logger.log = ctx ? ctx->system.log : NULL;
    logger.user = ctx ? ctx->system.user : NULL;
    logger.function = function;
    return logger;
}

GLBK__DEF glbk_result glbk__refuse(const glbk_context *ctx, glbk_result result, const char *function,
                                   const char *field, const char *text)
{
    const glbk__logger logger = glbk__logger_of(ctx, function);
    glbk__log_text(&logger, field, text);
    return result;
}

GLBK__DEF glbk_result glbk__refuse_value(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *field, double value, const char *wanted)
{
    const glbk__logger logger = glbk__logger_of(ctx, function);
    glbk__log_value(&logger, field, value, wanted);
    return result;
}

GLBK__DEF glbk_result glbk__refuse_range(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *field, double value, double low, double high)
{
    glbk__message m;
    m.used = 0;
    glbk__message_number(&m, low);
    if (high > low) {
        glbk__message_text(&m, "..");
        glbk__message_number(&m, high);
    }
    return glbk__refuse_value(ctx, result, function, field, value, m.text);
}

/* ==== src/gl/errors.h ==== */

/* ---- errors: GL's error flag ---- */

enum {
    GLBK__OUT_OF_MEMORY = 0x0505, GLBK__CONTEXT_LOST = 0x0507, GLBK__DRAW_FRAMEBUFFER_BINDING = 0x8CA6
};

/* Takes all errors that GL keeps, of which there may be one for each part of a distributed driver, and
   returns `otherwise` if there was one. The count is bounded since a driver without a context may return an
   error for ever. */
static glbk_result glbk__take_errors(glbk_context *ctx, glbk_result otherwise)
{
    uint32_t first = ctx->gl.GetError(), error = first;
    int i;
    for (i = 0; error && i < 64; i++) {
        if (error == GLBK__CONTEXT_LOST) {
            ctx->lost = 1;
            return GLBK_ERR_LOST;
        }
        if (error == GLBK__OUT_OF_MEMORY) first = error;
        error = ctx->gl.GetError();
    }
    if (!first) return GLBK_OK;
    glbk__log_constant(ctx, otherwise == GLBK_ERR_PENDING ? "before this call: GL error " : "GL error ",
                       first);
    return otherwise == GLBK_ERR_GL && first == GLBK__OUT_OF_MEMORY ? GLBK_ERR_GL_MEMORY : otherwise;
}

GLBK__DEF glbk_result glbk__enter(glbk_context *ctx)
{
    if (!ctx) return GLBK_ERR_ARGUMENT;
    return ctx->lost ? GLBK_ERR_LOST : glbk__take_errors(ctx, GLBK_ERR_PENDING);
}

GLBK__DEF glbk_result glbk__enter_create(glbk_context *ctx, const char *function, void *out, size_t bytes)
{
    if (out) memset(out, 0, bytes);
    if (!ctx) return GLBK_ERR_ARGUMENT;
    return out ? glbk__enter(ctx) : glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "out", "is NULL");
}

GLBK__DEF glbk_result glbk__leave(glbk_context *ctx) { return glbk__take_errors(ctx, GLBK_ERR_GL); }

/* Begins a call of a frame, which asks GL only if the user wants it: the answer makes browsers and drivers
   with threads of their own wait for all that was asked of them before. */
GLBK__DEF glbk_result glbk__enter_frame(glbk_context *ctx)
{
    if (!ctx || ctx->check) return glbk__enter(ctx);
    return ctx->lost ? GLBK_ERR_LOST : GLBK_OK;
}

GLBK__DEF glbk_result glbk__leave_frame(glbk_context *ctx) { return ctx->check ? glbk__leave(ctx) : GLBK_OK; }

GLBK__DEF glbk_result glbk__leave_created(glbk_context *ctx, glbk_result result)
{
    return result == GLBK_OK ? glbk__leave(ctx) : result;
}

GLBK__DEF glbk_result glbk__check_bound(const glbk_context *ctx, const char *function)
{
    int32_t bound = 0;
    if (!ctx->check || !ctx->inner) return GLBK_OK;
    ctx->gl.GetIntegerv(GLBK__DRAW_FRAMEBUFFER_BINDING, &bound);
    if ((uint32_t)bound != ctx->inner) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ORDER, function, "a technique's framebuffer",
                        "is still bound: after its passes bind your own");
}

GLBK_DEF glbk_result glbk_check(glbk_context *ctx)
{
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (ctx->lost) return GLBK_ERR_LOST;
    result = glbk__leave(ctx);
    return result == GLBK_OK ? glbk__check_bound(ctx, __func__) : result;
}

/* ==== src/gl/init.h ==== */

/* ---- init: functions and what the context can do ---- */

enum {
    GLBK__RENDERER = 0x1F01, GLBK__VERSION_TEXT = 0x1F02, GLBK__EXTENSIONS = 0x1F03,
    GLBK__NUM_EXTENSIONS = 0x821D, GLBK__CLIP_ORIGIN = 0x935C, GLBK__CLIP_DEPTH_MODE = 0x935D,
    GLBK__LOWER_LEFT = 0x8CA1, GLBK__UPPER_LEFT = 0x8CA2, GLBK__NEGATIVE_ONE_TO_ONE = 0x935E,
    GLBK__MAX_TEXTURE_SIZE = 0x0D33, GLBK__MAX_ARRAY_TEXTURE_LAYERS = 0x88FF, GLBK__MAX_DRAW_BUFFERS = 0x8824,
    GLBK__MAX_SHADER_STORAGE_BLOCK_SIZE = 0x90DE, GLBK__ALIASED_POINT_SIZE_RANGE = 0x846D,
    GLBK__MAX_TEXTURE_UNITS = 0x8B4D /* MAX_COMBINED_TEXTURE_IMAGE_UNITS */,
    GLBK__MAX_BLOCK_BINDINGS = 0x8A2F /* MAX_UNIFORM_BUFFER_BINDINGS */
};

enum {
    GLBK__GROUP_CORE, GLBK__GROUP_ES, GLBK__GROUP_DESK, GLBK__GROUP_TARGETS, GLBK__GROUP_BLENDS,
    GLBK__GROUP_COMPUTE, GLBK__GROUP_CLIP, GLBK__GROUP_CLAMP
};

/* The names without "gl", one after the other, each ended by 0, and their groups, in the order of
   glbk_functions, which holds nothing but pointers to them: a table of pointers to names would be six times
   as large in a program that can be moved. */
static const char glbk__function_names[] =
#define GLBK__ENTRY(group, type, name, parameters) #name "\0"
    GLBK_FUNCTIONS(GLBK__ENTRY);
#undef GLBK__ENTRY

static const uint8_t glbk__function_groups[] = {
#define GLBK__ENTRY(group, type, name, parameters) GLBK__GROUP_##group,
    GLBK_FUNCTIONS(GLBK__ENTRY)
#undef GLBK__ENTRY
};

/* Loads one group. Returns the name, without "gl", of a function that is missing, or NULL. */
static const char *glbk__load(glbk_context *ctx, const glbk_desc *desc, int group)
{
    const char *next = glbk__function_names;
    size_t i;
    for (i = 0; i < sizeof glbk__function_groups; i++, next += strlen(next) + 1) {
        const char *name = next;
        char whole[64] = "gl";
        glbk_proc_fn proc;
        if (glbk__function_groups[i] != group) continue;
        if (strcmp(name, "Barrier") == 0) name = "MemoryBarrier";
        if (group == GLBK__GROUP_CLIP && ctx->es) name = "ClipControlEXT";
        memcpy(whole + 2, name, strlen(name) + 1);
        proc = desc->get_proc_fn(whole, desc->user);
        if (!proc) return name;
        memcpy((char *)&ctx->gl + i * sizeof proc, &proc, sizeof proc);
    }
    return NULL;
}

/* Reads the version, the first number of a text like "4.5 (Core Profile) ...", "OpenGL ES 3.0 ..." or "OpenGL
   ES 3.0 (WebGL 2.0 ...)". */
static void glbk__read_version(glbk_context *ctx, const char *text)
{
    const char *s = text;
    uint32_t major = 0;
    ctx->es = strstr(text, "OpenGL ES") != NULL;
    ctx->webgl = strstr(text, "WebGL") != NULL;
    ctx->version = 0;
    while (*s && (*s < '0' || *s > '9')) s++;
    while (*s >= '0' && *s <= '9' && major < 100) major = 10 * major + (uint32_t)(*s++ - '0');
    if (s[0] == '.' && s[1] >= '0' && s[1] <= '9') ctx->version = 100 * major + 10 * (uint32_t)(s[1] - '0');
}

static int glbk__has_extension(const glbk_context *ctx, const char *name)
{
    int32_t count = 0, i;
    ctx->gl.GetIntegerv(GLBK__NUM_EXTENSIONS, &count);
    for (i = 0; i < count; i++) {
        const char *text = (const char *)ctx->gl.GetStringi(GLBK__EXTENSIONS, (uint32_t)i);
        if (text && strcmp(text, name) == 0) return 1;
    }
    return 0;
}

GLBK__DEF uint32_t glbk__get_integer(const glbk_context *ctx, uint32_t name)
{
    int32_t value[4] = { 0, 0, 0, 0 };
    ctx->gl.GetIntegerv(name, value);
    return (uint32_t)value[0];
}

/* Returns whether glClipControl works. WebGL also lists extensions that nobody has enabled; GL does not know
   their state then, which shows in the origin. */
static int glbk__has_clip_control(glbk_context *ctx, const glbk_desc *desc)
{
    uint32_t origin;
    if (!ctx->es && ctx->version < 450 && !glbk__has_extension(ctx, "GL_ARB_clip_control")) return 0;
    if (ctx->es && !glbk__has_extension(ctx, "GL_EXT_clip_control")) return 0;
    if (glbk__load(ctx, desc, GLBK__GROUP_CLIP)) return 0;
    origin = glbk__get_integer(ctx, GLBK__CLIP_ORIGIN);
    if (origin == GLBK__LOWER_LEFT || origin == GLBK__UPPER_LEFT) return 1;
    ctx->gl.GetError();
    return 0;
}

static void glbk__read_features(glbk_context *ctx, const glbk_desc *desc)
{
    float points[2] = { 1, 1 };
    int es32 = ctx->es && ctx->version >= 320, desk = !ctx->es;

    ctx->float_targets = desk || es32 || glbk__has_extension(ctx, "GL_EXT_color_buffer_float");
    ctx->float_blend = desk || es32 || (ctx->float_targets && glbk__has_extension(ctx, "GL_EXT_float_blend"));
    ctx->float_linear = desk || glbk__has_extension(ctx, "GL_OES_texture_float_linear");
    ctx->compute =
        desk && ctx->version >= 430 && !desc->core_only && !glbk__load(ctx, desc, GLBK__GROUP_COMPUTE);
    ctx->clip_control = glbk__has_clip_control(ctx, desc);
    ctx->each_target = desk || (es32 && !glbk__load(ctx, desc, GLBK__GROUP_TARGETS));
    ctx->each_blend =
        ctx->each_target && (es32 || ctx->version >= 400) && !glbk__load(ctx, desc, GLBK__GROUP_BLENDS);
    ctx->offset_clamp = desk &&
                        (ctx->version >= 460 || glbk__has_extension(ctx, "GL_ARB_polygon_offset_clamp")) &&
                        !glbk__load(ctx, desc, GLBK__GROUP_CLAMP);
    ctx->max_side = glbk__get_integer(ctx, GLBK__MAX_TEXTURE_SIZE);
    ctx->max_layers = glbk__get_integer(ctx, GLBK__MAX_ARRAY_TEXTURE_LAYERS);
    ctx->max_targets = glbk__get_integer(ctx, GLBK__MAX_DRAW_BUFFERS);
    if (ctx->max_targets > 8) ctx->max_targets = 8;
    if (ctx->compute) ctx->max_storage = glbk__get_integer(ctx, GLBK__MAX_SHADER_STORAGE_BLOCK_SIZE);
    ctx->gl.GetFloatv(GLBK__ALIASED_POINT_SIZE_RANGE, points);
    ctx->max_point_side = points[1];
}

/* Checks that `least` bindings from `first` on are among the `has` ones of the context, and writes how many
   there are, up to `most`. */
static glbk_result glbk__check_first(const glbk_context *ctx, const char *field, uint32_t first, uint32_t has,
                                     uint32_t least, uint32_t most, uint32_t *out)
{
    const uint32_t last = has > least ? has - least : 0;
    if (first > last) return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, "glbk_init", field, first, 0, last);
    *out = has - first < most ? has - first : most;
    return GLBK_OK;
}

static glbk_result glbk__init(glbk_context *ctx, const glbk_desc *desc)
{
    const char *missing, *version;
    glbk_result result;

    missing = glbk__load(ctx, desc, GLBK__GROUP_CORE);
    if (missing) return glbk__fail(ctx, GLBK_ERR_FUNCTION, "glbk_init: missing: gl", missing);
    version = (const char *)ctx->gl.GetString(GLBK__VERSION_TEXT);
    if (!version) return glbk__fail(ctx, GLBK_ERR_CONTEXT, "glbk_init: ", "no GL context is current");
    result = glbk__take_errors(ctx, GLBK_ERR_PENDING);
    if (result != GLBK_OK) return result;
    glbk__read_version(ctx, version);
    if (ctx->version < (ctx->es ? 300u : 330u))
        return glbk__fail(ctx, GLBK_ERR_OLD_CONTEXT, "glbk_init: this is OpenGL ", version);
    missing = glbk__load(ctx, desc, ctx->es ? GLBK__GROUP_ES : GLBK__GROUP_DESK);
    if (!missing && !ctx->es) missing = glbk__load(ctx, desc, GLBK__GROUP_TARGETS);
    if (missing) return glbk__fail(ctx, GLBK_ERR_FUNCTION, "glbk_init: missing: gl", missing);
    ctx->renderer = (const char *)ctx->gl.GetString(GLBK__RENDERER);
    if (!ctx->renderer) ctx->renderer = "";
    glbk__read_features(ctx, desc);
    result = glbk__check_first(ctx, "desc.first_unit", desc->first_unit,
                               glbk__get_integer(ctx, GLBK__MAX_TEXTURE_UNITS), GLBK_UNITS, GLBK_MAX_UNITS,
                               &ctx->unit_count);
    if (result == GLBK_OK)
        result = glbk__check_first(ctx, "desc.first_block", desc->first_block,
                                   glbk__get_integer(ctx, GLBK__MAX_BLOCK_BINDINGS), GLBK_BLOCKS,
                                   GLBK_MAX_BLOCKS, &ctx->block_count);
    if (result != GLBK_OK) return result;
    ctx->gl.GenVertexArrays(1, &ctx->vertex_array);
    ctx->gl.GenBuffers(1, &ctx->shown);
    return glbk__leave(ctx);
}

GLBK_DEF glbk_result glbk_init(glbk_context *ctx, const glbk_desc *desc)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    memset(ctx, 0, sizeof *ctx);
    if (!desc) return GLBK_ERR_ARGUMENT;
    ctx->system = desc->system;
    ctx->first_unit = desc->first_unit;
    ctx->first_block = desc->first_block;
    ctx->check = desc->check != 0;
    if (!desc->get_proc_fn)
        result = glbk__refuse(ctx, GLBK_ERR_DESC, __func__, "desc.get_proc_fn", "is NULL");
    else if (!glbk__allocator_valid(desc->system.allocator.alloc_fn, desc->system.allocator.free_fn))
        result = glbk__refuse(ctx, GLBK_ERR_DESC, __func__, "desc.system.allocator",
                              "has one of its two functions");
    else
        result = glbk__init(ctx, desc);
    if (result != GLBK_OK) glbk_free(ctx);
    return result;
}

GLBK_DEF void glbk_free(glbk_context *ctx)
{
    if (!ctx) return;
    if (ctx->vertex_array && !ctx->lost) ctx->gl.DeleteVertexArrays(1, &ctx->vertex_array);
    if (ctx->shown && !ctx->lost) ctx->gl.DeleteBuffers(1, &ctx->shown);
    memset(ctx, 0, sizeof *ctx);
    ctx->lost = 1;
}

GLBK_DEF void glbk_abandon(glbk_context *ctx)
{
    if (ctx) ctx->lost = 1;
}

/* ==== src/gl/textures.h ==== */

/* ---- textures: formats, storage, and texels that go up ---- */

/* GL's constants of formats. */
enum {
    GLBK__RED = 0x1903, GLBK__RGBA = 0x1908, GLBK__RED_INTEGER = 0x8D94, GLBK__RGBA_INTEGER = 0x8D99,
    GLBK__RG_INTEGER = 0x8228, GLBK__RG = 0x8227, GLBK__DEPTH_COMPONENT = 0x1902, GLBK__R8 = 0x8229,
    GLBK__RGBA8 = 0x8058, GLBK__SRGB8_ALPHA8 = 0x8C43, GLBK__R8UI = 0x8232, GLBK__RGBA8UI = 0x8D7C,
    GLBK__R16UI = 0x8234, GLBK__RG16UI = 0x823A, GLBK__RGBA16UI = 0x8D76, GLBK__R32UI = 0x8236,
    GLBK__RG32UI = 0x823C, GLBK__RGBA32UI = 0x8D70, GLBK__R16F = 0x822D, GLBK__RGBA16F = 0x881A,
    GLBK__R32F = 0x822E, GLBK__RG32F = 0x8230, GLBK__RGBA32F = 0x8814, GLBK__DEPTH_COMPONENT24 = 0x81A6,
    GLBK__DEPTH_COMPONENT32F = 0x8CAC
};

/* GL's constants of textures, and of texels in memory. */
enum {
    GLBK__TEXTURE_BINDING_2D = 0x8069, GLBK__TEXTURE_BINDING_2D_ARRAY = 0x8C1D,
    GLBK__TEXTURE_MAX_LEVEL = 0x813D, GLBK__TEXTURE_MIN_FILTER = 0x2801, GLBK__TEXTURE_MAG_FILTER = 0x2800,
    GLBK__TEXTURE_WRAP_S = 0x2802, GLBK__TEXTURE_WRAP_T = 0x2803, GLBK__TEXTURE_COMPARE_MODE = 0x884C,
    GLBK__TEXTURE_COMPARE_FUNC = 0x884D, GLBK__COMPARE_REF_TO_TEXTURE = 0x884E, GLBK__LEQUAL = 0x0203,
    GLBK__NEAREST = 0x2600, GLBK__LINEAR = 0x2601, GLBK__NEAREST_MIPMAP_NEAREST = 0x2700,
    GLBK__LINEAR_MIPMAP_LINEAR = 0x2703, GLBK__REPEAT = 0x2901, GLBK__CLAMP_TO_EDGE = 0x812F,
    GLBK__UNPACK_SWAP_BYTES = 0x0CF0, GLBK__UNPACK_LSB_FIRST = 0x0CF1, GLBK__UNPACK_ROW_LENGTH = 0x0CF2,
    GLBK__UNPACK_SKIP_ROWS = 0x0CF3, GLBK__UNPACK_SKIP_PIXELS = 0x0CF4, GLBK__UNPACK_ALIGNMENT = 0x0CF5,
    GLBK__UNPACK_SKIP_IMAGES = 0x806D, GLBK__UNPACK_IMAGE_HEIGHT = 0x806E,
    GLBK__PACK_SWAP_BYTES = 0x0D00, GLBK__PACK_LSB_FIRST = 0x0D01, GLBK__PACK_ROW_LENGTH = 0x0D02,
    GLBK__PACK_SKIP_ROWS = 0x0D03, GLBK__PACK_SKIP_PIXELS = 0x0D04, GLBK__PACK_ALIGNMENT = 0x0D05,
    GLBK__PACK_SKIP_IMAGES = 0x806B, GLBK__PACK_IMAGE_HEIGHT = 0x806C,
    GLBK__PIXEL_PACK_BUFFER = 0x88EB, GLBK__PIXEL_UNPACK_BUFFER = 0x88EC,
    GLBK__PIXEL_PACK_BUFFER_BINDING = 0x88ED, GLBK__PIXEL_UNPACK_BUFFER_BINDING = 0x88EF
};

typedef struct glbk__format_info {
    uint16_t internal, format, type, bytes;         /* a texel */
} glbk__format_info;

/* In the order of glbk_format. */
static const glbk__format_info glbk__formats[] = {
    { 0, 0, 0, 0 },                                                 /* NONE */
    { 0, 0, 0, 0 },                                                 /* COLOR: resolved before */
    { GLBK__R8, GLBK__RED, GLBK_GL_UNSIGNED_BYTE, 1 },
    { GLBK__RGBA8, GLBK__RGBA, GLBK_GL_UNSIGNED_BYTE, 4 },
    { GLBK__SRGB8_ALPHA8, GLBK__RGBA, GLBK_GL_UNSIGNED_BYTE, 4 },
    { GLBK__R8UI, GLBK__RED_INTEGER, GLBK_GL_UNSIGNED_BYTE, 1 },
    { GLBK__RGBA8UI, GLBK__RGBA_INTEGER, GLBK_GL_UNSIGNED_BYTE, 4 },
    { GLBK__R16UI, GLBK__RED_INTEGER, GLBK_GL_UNSIGNED_SHORT, 2 },
    { GLBK__RG16UI, GLBK__RG_INTEGER, GLBK_GL_UNSIGNED_SHORT, 4 },
    { GLBK__RGBA16UI, GLBK__RGBA_INTEGER, GLBK_GL_UNSIGNED_SHORT, 8 },
    { GLBK__R32UI, GLBK__RED_INTEGER, GLBK_GL_UNSIGNED_INT, 4 },
    { GLBK__RG32UI, GLBK__RG_INTEGER, GLBK_GL_UNSIGNED_INT, 8 },
    { GLBK__RGBA32UI, GLBK__RGBA_INTEGER, GLBK_GL_UNSIGNED_INT, 16 },
    { GLBK__R16F, GLBK__RED, GLBK_GL_HALF_FLOAT, 2 },
    { GLBK__RGBA16F, GLBK__RGBA, GLBK_GL_HALF_FLOAT, 8 },
    { GLBK__R32F, GLBK__RED, GLBK_GL_FLOAT, 4 },
    { GLBK__RG32F, GLBK__RG, GLBK_GL_FLOAT, 8 },
    { GLBK__RGBA32F, GLBK__RGBA, GLBK_GL_FLOAT, 16 },
    { GLBK__DEPTH_COMPONENT24, GLBK__DEPTH_COMPONENT, GLBK_GL_UNSIGNED_INT, 4 },
    { GLBK__DEPTH_COMPONENT32F, GLBK__DEPTH_COMPONENT, GLBK_GL_FLOAT, 4 }
};

GLBK__DEF uint32_t glbk__texel_bytes(glbk_format format) { return glbk__formats[format].bytes; }

static int glbk__is_depth(glbk_format f) { return f == GLBK_FORMAT_DEPTH24 || f == GLBK_FORMAT_DEPTH32F; }

static int glbk__is_integer(glbk_format f)
{
    const uint32_t format = glbk__formats[f].format;
    return format == GLBK__RED_INTEGER || format == GLBK__RG_INTEGER || format == GLBK__RGBA_INTEGER;
}

static int glbk__is_float(glbk_format f)
{
    return !glbk__is_depth(f) &&
           (glbk__formats[f].type == GLBK_GL_FLOAT || glbk__formats[f].type == GLBK_GL_HALF_FLOAT);
}

/* Row lengths, offsets, byte order and pixel buffers that the user has set would change which bytes GL reads
   or writes; so a transfer sets them to its own values, and puts the user's back. */
enum { GLBK__UNPACK, GLBK__PACK, GLBK__STORE_COUNT = 8 };

static const uint32_t glbk__store_names[2][GLBK__STORE_COUNT] = {
    { GLBK__UNPACK_ALIGNMENT, GLBK__UNPACK_ROW_LENGTH, GLBK__UNPACK_SKIP_ROWS, GLBK__UNPACK_SKIP_PIXELS,
      GLBK__UNPACK_IMAGE_HEIGHT, GLBK__UNPACK_SKIP_IMAGES, GLBK__UNPACK_SWAP_BYTES, GLBK__UNPACK_LSB_FIRST },
    { GLBK__PACK_ALIGNMENT, GLBK__PACK_ROW_LENGTH, GLBK__PACK_SKIP_ROWS, GLBK__PACK_SKIP_PIXELS,
      GLBK__PACK_IMAGE_HEIGHT, GLBK__PACK_SKIP_IMAGES, GLBK__PACK_SWAP_BYTES, GLBK__PACK_LSB_FIRST }
};
static const uint32_t glbk__store_buffer[2][2] = {
    { GLBK__PIXEL_UNPACK_BUFFER, GLBK__PIXEL_UNPACK_BUFFER_BINDING },
    { GLBK__PIXEL_PACK_BUFFER, GLBK__PIXEL_PACK_BUFFER_BINDING }
};

/* Returns how many of them there are: ES knows the first six for unpacking, the first four for packing. */
static int glbk__store_count(const glbk_context *ctx, int way)
{
    return !ctx->es ? GLBK__STORE_COUNT : way == GLBK__UNPACK ? 6 : 4;
}

static void glbk__store_begin(const glbk_context *ctx, int way, glbk__store *old)
{
    int i;
    for (i = 0; i < glbk__store_count(ctx, way); i++) {
        ctx->gl.GetIntegerv(glbk__store_names[way][i], &old->value[i]);
        ctx->gl.PixelStorei(glbk__store_names[way][i], i == 0);
    }
    ctx->gl.GetIntegerv(glbk__store_buffer[way][1], &old->buffer);
    ctx->gl.BindBuffer(glbk__store_buffer[way][0], 0);
}

static void glbk__store_end(const glbk_context *ctx, int way, const glbk__store *old)
{
    int i;
    for (i = 0; i < glbk__store_count(ctx, way); i++)
        ctx->gl.PixelStorei(glbk__store_names[way][i], old->value[i]);
    ctx->gl.BindBuffer(glbk__store_buffer[way][0], (uint32_t)old->buffer);
}

static uint32_t glbk__binding_of(uint32_t gl_target)
{
    return gl_target == GLBK_GL_TEXTURE_2D ? GLBK__TEXTURE_BINDING_2D : GLBK__TEXTURE_BINDING_2D_ARRAY;
}

static uint32_t glbk__all_levels(uint32_t width, uint32_t height)
{
    uint32_t side = width > height ? width : height, levels = 1;
    while (side > 1) side /= 2, levels++;
    return levels;
}

/* Checks that the format allows the sampling, which is one of the enum. */
static glbk_result glbk__check_sampling(const glbk_context *ctx, const char *function,
                                        const glbk_texture_desc *d)
{
    const glbk_result bad = GLBK_ERR_DESC;
    if (d->sampling == GLBK_SAMPLING_COMPARE)
        return glbk__is_depth(d->format) ? GLBK_OK
                                         : glbk__refuse(ctx, bad, function, "desc.sampling",
                                                        "is COMPARE, which only depth formats have");
    if (d->sampling != GLBK_SAMPLING_LINEAR && d->sampling != GLBK_SAMPLING_MIPMAPS) return GLBK_OK;
    if (glbk__is_integer(d->format) || glbk__is_depth(d->format))
        return glbk__refuse(ctx, bad, function, "desc.sampling",
                            "is LINEAR or MIPMAPS, which formats of integers and depth do not have");
    if (glbk__formats[d->format].type == GLBK_GL_FLOAT && !ctx->float_linear)
        return glbk__refuse(ctx, bad, function, "desc.sampling",
                            "is LINEAR or MIPMAPS, which this context does not have for 32-bit floats");
    if (d->sampling == GLBK_SAMPLING_MIPMAPS && d->data && glbk__is_float(d->format) && !ctx->float_targets)
        return glbk__refuse(
            ctx, GLBK_ERR_FLOAT_TARGET, function, "desc.sampling",
            "is MIPMAPS, which this context makes of no floats, since it cannot draw to them");
    return GLBK_OK;
}

/* Checks a size: below `low` the desc is wrong, above `high` the context's limit is passed. */
static glbk_result glbk__check_extent(const glbk_context *ctx, const char *function, const char *field,
                                      uint32_t value, uint32_t low, uint32_t high)
{
    if (value >= low && value <= high) return GLBK_OK;
    return glbk__refuse_range(ctx, value > high ? GLBK_ERR_LIMIT : GLBK_ERR_DESC, function, field, value, low,
                              high);
}

/* Checks a desc and resolves its defaults in place. */
static glbk_result glbk__check_texture(const glbk_context *ctx, const char *function, glbk_texture_desc *d)
{
    uint32_t most;
    glbk_result result;
    if (d->format <= GLBK_FORMAT_NONE || d->format >= GLBK_FORMAT_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.format", (double)d->format,
                                  "a glbk_format, not NONE");
    if ((unsigned)d->sampling >= GLBK_SAMPLING_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.sampling", (double)d->sampling,
                                  "a glbk_sampling");
    if (d->format == GLBK_FORMAT_COLOR)
        d->format = ctx->float_targets ? GLBK_FORMAT_RGBA32F : GLBK_FORMAT_RGBA32UI;
    result = glbk__check_extent(ctx, function, "desc.width", d->width, 1, ctx->max_side);
    if (result == GLBK_OK)
        result = glbk__check_extent(ctx, function, "desc.height", d->height, 1, ctx->max_side);
    if (result == GLBK_OK)
        result = glbk__check_extent(ctx, function, "desc.layers", d->layers, 0, ctx->max_layers);
    if (result != GLBK_OK) return result;
    most = glbk__all_levels(d->width, d->height);
    if (!d->levels) d->levels = d->sampling == GLBK_SAMPLING_MIPMAPS ? most : 1;
    if (d->levels > most)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.levels", d->levels, 0, most);
    return glbk__check_sampling(ctx, function, d);
}

static uint32_t glbk__level_side(uint32_t size, uint32_t level) { return size >> level ? size >> level : 1; }

/* Allots all levels at once, on ES and WebGL. Makers of pyramids draw to a level while only the level below
   can be read (BASE_LEVEL, MAX_LEVEL), and ES does not allow that if the levels were allotted one by
   one. */
static void glbk__store_texture(const glbk_context *ctx, const glbk_texture_desc *d, uint32_t target)
{
    const glbk__format_info *f = &glbk__formats[d->format];
    const int32_t levels = (int32_t)d->levels, width = (int32_t)d->width, height = (int32_t)d->height;
    const int32_t layers = (int32_t)d->layers;
    if (layers) ctx->gl.TexStorage3D(target, levels, (uint32_t)f->internal, width, height, layers);
    else ctx->gl.TexStorage2D(target, levels, (uint32_t)f->internal, width, height);
    if (!d->data) return;
    if (layers) ctx->gl.TexSubImage3D(target, 0, 0, 0, 0, width, height, layers, f->format, f->type, d->data);
    else ctx->gl.TexSubImage2D(target, 0, 0, 0, width, height, f->format, f->type, d->data);
    if (d->sampling == GLBK_SAMPLING_MIPMAPS) ctx->gl.GenerateMipmap(target);
}

/* Gives the texture that is bound to target its storage and parameters. */
static void glbk__fill_texture(const glbk_context *ctx, const glbk_texture_desc *d, uint32_t target)
{
    const glbk__format_info *f = &glbk__formats[d->format];
    int linear = d->sampling == GLBK_SAMPLING_LINEAR || d->sampling == GLBK_SAMPLING_COMPARE;
    int mipmaps = d->sampling == GLBK_SAMPLING_MIPMAPS, wrap = d->repeat ? GLBK__REPEAT : GLBK__CLAMP_TO_EDGE;
    const int smaller = mipmaps         ? GLBK__LINEAR_MIPMAP_LINEAR
                        : linear        ? GLBK__LINEAR
                        : d->levels > 1 ? GLBK__NEAREST_MIPMAP_NEAREST
                                        : GLBK__NEAREST;
    uint32_t level;

    /* Parameters come first: Mesa allots levels by them, and otherwise forgets some of small arrays of
       integers. */
    ctx->gl.TexParameteri(target, GLBK__TEXTURE_MAX_LEVEL, (int32_t)d->levels - 1);
    ctx->gl.TexParameteri(target, GLBK__TEXTURE_MIN_FILTER, smaller);
    ctx->gl.TexParameteri(target, GLBK__TEXTURE_MAG_FILTER, mipmaps || linear ? GLBK__LINEAR : GLBK__NEAREST);
    ctx->gl.TexParameteri(target, GLBK__TEXTURE_WRAP_S, wrap);
    ctx->gl.TexParameteri(target, GLBK__TEXTURE_WRAP_T, wrap);
    if (d->sampling == GLBK_SAMPLING_COMPARE) {
        ctx->gl.TexParameteri(target, GLBK__TEXTURE_COMPARE_MODE, GLBK__COMPARE_REF_TO_TEXTURE);
        ctx->gl.TexParameteri(target, GLBK__TEXTURE_COMPARE_FUNC, GLBK__LEQUAL);
    }
    if (ctx->es) {
        glbk__store_texture(ctx, d, target);
        return;
    }
    for (level = 0; level < d->levels; level++) {
        int32_t width = (int32_t)glbk__level_side(d->width, level);
        int32_t height = (int32_t)glbk__level_side(d->height, level);
        const void *data = level == 0 ? d->data : NULL;
        if (d->layers)
            ctx->gl.TexImage3D(target, (int32_t)level, f->internal, width, height, (int32_t)d->layers, 0,
                               f->format, f->type, data);
        else
            ctx->gl.TexImage2D(target, (int32_t)level, f->internal, width, height, 0, f->format, f->type,
                               data);
    }
    if (mipmaps && d->data) ctx->gl.GenerateMipmap(target);
}

GLBK_DEF glbk_result glbk_texture_create(glbk_context *ctx, const glbk_texture_desc *desc, glbk_texture *out)
{
    glbk_texture_desc d;
    glbk__store store;
    int32_t bound = 0;
    glbk_result result;

    result = glbk__enter_create(ctx, __func__, out, sizeof *out);
    if (result != GLBK_OK) return result;
    if (!desc) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "desc", "is NULL");
    d = *desc;
    result = glbk__check_texture(ctx, __func__, &d);
    if (result != GLBK_OK) return result;
    out->gl_target = d.layers ? GLBK_GL_TEXTURE_2D_ARRAY : GLBK_GL_TEXTURE_2D;
    out->format = d.format;
    out->width = d.width;
    out->height = d.height;
    out->layers = d.layers;
    out->levels = d.levels;

    ctx->gl.GetIntegerv(glbk__binding_of(out->gl_target), &bound);
    glbk__store_begin(ctx, GLBK__UNPACK, &store);
    ctx->gl.GenTextures(1, &out->name);
    ctx->gl.BindTexture(out->gl_target, out->name);
    glbk__fill_texture(ctx, &d, out->gl_target);
    ctx->gl.BindTexture(out->gl_target, (uint32_t)bound);
    glbk__store_end(ctx, GLBK__UNPACK, &store);
    result = glbk__leave(ctx);
    if (result != GLBK_OK) glbk_texture_free(ctx, out);
    return result;
}

GLBK__DEF void glbk__upload_begin(const glbk_context *ctx, const glbk_texture *t, glbk__upload *old)
{
    old->bound = 0;
    ctx->gl.GetIntegerv(glbk__binding_of(t->gl_target), &old->bound);
    glbk__store_begin(ctx, GLBK__UNPACK, &old->store);
    ctx->gl.BindTexture(t->gl_target, t->name);
}

GLBK__DEF void glbk__upload_end(const glbk_context *ctx, const glbk_texture *t, const glbk__upload *old)
{
    ctx->gl.BindTexture(t->gl_target, (uint32_t)old->bound);
    glbk__store_end(ctx, GLBK__UNPACK, &old->store);
}

GLBK__DEF void glbk__upload_box(const glbk_context *ctx, const glbk_texture *t, const glbk_box *b,
                             const void *data)
{
    const glbk__format_info *f = &glbk__formats[t->format];
    const int32_t level = (int32_t)b->level, x = (int32_t)b->x, y = (int32_t)b->y;
    const int32_t width = (int32_t)b->width, height = (int32_t)b->height;
    if (t->layers)
        ctx->gl.TexSubImage3D(t->gl_target, level, x, y, (int32_t)b->layer, width, height,
                              b->layers ? (int32_t)b->layers : 1, f->format, f->type, data);
    else
        ctx->gl.TexSubImage2D(t->gl_target, level, x, y, width, height, f->format, f->type, data);
}

/* Checks where a run of texels or layers ends. */
static glbk_result glbk__check_span(const glbk_context *ctx, const char *function, const char *field,
                                    uint64_t end, uint64_t most)
{
    return end <= most
               ? GLBK_OK
               : glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, function, field, (double)end, 0, (double)most);
}

/* Checks that a box lies within the texture. */
static glbk_result glbk__check_box(const glbk_context *ctx, const char *function, const glbk_texture *t,
                                   const glbk_box *b)
{
    glbk_result result;
    if (b->level >= t->levels)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, function, "box.level", b->level, 0,
                                  (double)t->levels - 1);
    result = glbk__check_span(ctx, function, "box.x + box.width", (uint64_t)b->x + b->width,
                              glbk__level_side(t->width, b->level));
    if (result == GLBK_OK)
        result = glbk__check_span(ctx, function, "box.y + box.height", (uint64_t)b->y + b->height,
                                  glbk__level_side(t->height, b->level));
    if (result == GLBK_OK)
        result =
            glbk__check_span(ctx, function, "box.layer + box.layers",
                             (uint64_t)b->layer + (b->layers ? b->layers : 1), t->layers ? t->layers : 1);
    return result;
}

GLBK_DEF glbk_result glbk_texture_update(glbk_context *ctx, const glbk_texture *t, const glbk_box *box,
                                         const void *data)
{
    glbk__upload old;
    glbk_result result = glbk__enter_frame(ctx);

    if (result != GLBK_OK) return result;
    if (!t || !t->name) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "texture", "was not created");
    if (!box) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "box", "is NULL");
    if (!data) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "data", "is NULL");
    result = glbk__check_box(ctx, __func__, t, box);
    if (result != GLBK_OK) return result;
    glbk__upload_begin(ctx, t, &old);
    glbk__upload_box(ctx, t, box, data);
    glbk__upload_end(ctx, t, &old);
    return glbk__leave_frame(ctx);
}

GLBK_DEF void glbk_texture_free(glbk_context *ctx, glbk_texture *texture)
{
    if (!texture) return;
    if (ctx && !ctx->lost && texture->name) ctx->gl.DeleteTextures(1, &texture->name);
    memset(texture, 0, sizeof *texture);
}

/* ==== src/gl/buffers.h ==== */

/* ---- buffers: through the copy target, which no vertex array or draw looks at ---- */

enum { GLBK__DYNAMIC_DRAW = 0x88E8, GLBK__ELEMENT_ARRAY_BUFFER_BINDING = 0x8895 };

static glbk_result glbk__buffer_make(glbk_context *ctx, const char *function, size_t bytes, const void *data,
                                     int indices, glbk_buffer *out)
{
    const uint32_t target = indices ? GLBK_GL_ELEMENT_ARRAY_BUFFER : GLBK_GL_COPY_WRITE_BUFFER;
    int32_t bound = 0;
    glbk_result result;

    result = glbk__enter_create(ctx, function, out, sizeof *out);
    if (result != GLBK_OK) return result;
    if (!bytes || bytes > PTRDIFF_MAX)
        return glbk__refuse_range(ctx, bytes ? GLBK_ERR_LIMIT : GLBK_ERR_ARGUMENT, function, "bytes",
                                  (double)bytes, 1, (double)PTRDIFF_MAX);
    ctx->gl.GetIntegerv(indices ? (uint32_t)GLBK__ELEMENT_ARRAY_BUFFER_BINDING : target, &bound);
    ctx->gl.GenBuffers(1, &out->name);
    ctx->gl.BindBuffer(target, out->name);
    ctx->gl.BufferData(target, (ptrdiff_t)bytes, data, GLBK_GL_STATIC_DRAW);
    ctx->gl.BindBuffer(target, (uint32_t)bound);
    out->bytes = bytes;
    result = glbk__leave(ctx);
    if (result != GLBK_OK) glbk_buffer_free(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_buffer_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out)
{
    return glbk__buffer_make(ctx, __func__, bytes, data, 0, out);
}

/* WebGL lets a buffer hold indices only if it was bound as such first. Elsewhere indices go through the copy
   target, since the binding of indices belongs to a vertex array, and in core profiles none may be bound. */
GLBK_DEF glbk_result glbk_indices_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out)
{
    return glbk__buffer_make(ctx, __func__, bytes, data, ctx && ctx->webgl, out);
}

/* Checks that a run of bytes lies within a buffer, and that the memory for it, an argument of this name, is
   not NULL. */
static glbk_result glbk__check_run(const glbk_context *ctx, const char *function, const glbk_buffer *buffer,
                                   size_t offset, size_t bytes, const void *memory, const char *name)
{
    const glbk_result bad = GLBK_ERR_ARGUMENT;
    if (!memory) return glbk__refuse(ctx, bad, function, name, "is NULL");
    if (!buffer || !buffer->name) return glbk__refuse(ctx, bad, function, "buffer", "was not created");
    if (offset > buffer->bytes)
        return glbk__refuse_range(ctx, bad, function, "offset", (double)offset, 0, (double)buffer->bytes);
    if (bytes <= buffer->bytes - offset) return GLBK_OK;
    return glbk__refuse_range(ctx, bad, function, "bytes", (double)bytes, 0,
                              (double)(buffer->bytes - offset));
}

GLBK_DEF glbk_result glbk_buffer_update(glbk_context *ctx, const glbk_buffer *buffer, size_t offset,
                                        size_t bytes, const void *data)
{
    const uint32_t target = GLBK_GL_COPY_WRITE_BUFFER;
    int32_t bound = 0;
    glbk_result result = glbk__enter_frame(ctx);

    if (result == GLBK_OK) result = glbk__check_run(ctx, __func__, buffer, offset, bytes, data, "data");
    if (result != GLBK_OK) return result;
    ctx->gl.GetIntegerv(target, &bound);
    ctx->gl.BindBuffer(target, buffer->name);
    if (bytes == buffer->bytes) ctx->gl.BufferData(target, (ptrdiff_t)bytes, data, GLBK__DYNAMIC_DRAW);
    else ctx->gl.BufferSubData(target, (ptrdiff_t)offset, (ptrdiff_t)bytes, data);
    ctx->gl.BindBuffer(target, (uint32_t)bound);
    return glbk__leave_frame(ctx);
}

GLBK_DEF glbk_result glbk_buffer_read(glbk_context *ctx, const glbk_buffer *buffer, size_t offset,
                                      size_t bytes, void *out)
{
    int32_t bound = 0;
    glbk_result result = glbk__enter(ctx);

    if (result == GLBK_OK) result = glbk__check_run(ctx, __func__, buffer, offset, bytes, out, "out");
    if (result != GLBK_OK) return result;
    if (ctx->es)
        return glbk__refuse(ctx, GLBK_ERR_FEATURE, __func__, "ctx",
                            "is of OpenGL ES, which cannot read buffers");
    ctx->gl.GetIntegerv(GLBK_GL_COPY_WRITE_BUFFER, &bound);
    ctx->gl.BindBuffer(GLBK_GL_COPY_WRITE_BUFFER, buffer->name);
    ctx->gl.GetBufferSubData(GLBK_GL_COPY_WRITE_BUFFER, (ptrdiff_t)offset, (ptrdiff_t)bytes, out);
    ctx->gl.BindBuffer(GLBK_GL_COPY_WRITE_BUFFER, (uint32_t)bound);
    return glbk__leave(ctx);
}

GLBK_DEF void glbk_buffer_free(glbk_context *ctx, glbk_buffer *buffer)
{
    if (!buffer) return;
    if (ctx && !ctx->lost && buffer->name) ctx->gl.DeleteBuffers(1, &buffer->name);
    memset(buffer, 0, sizeof *buffer);
}

/* ==== src/gl/targets.h ==== */

/* ---- targets: framebuffers of textures, and their pixels read back ---- */

enum {
    GLBK__READ_FRAMEBUFFER_BINDING = 0x8CAA, GLBK__FRAMEBUFFER_COMPLETE = 0x8CD5,
    GLBK__CLAMP_READ_COLOR = 0x891C, GLBK__NONE = 0, GLBK__FALSE = 0
};

/* Checks one attachment and takes its size, which all attachments have in common. */
static glbk_result glbk__check_attachment(const glbk_context *ctx, const glbk_target_desc *d, uint32_t i,
                                          glbk_target *out)
{
    static const char function[] = "glbk_target_create";
    static const char names[][14] = { "desc.color[0]", "desc.color[1]", "desc.color[2]", "desc.color[3]",
                                      "desc.depth" };
    const int is_color = i < GLBK_MAX_ATTACHMENTS;
    const glbk_texture *t = is_color ? d->color[i] : d->depth;
    const uint32_t layer = is_color ? d->layer[i] : d->depth_layer, layers = t->layers ? t->layers : 1;

    if (is_color && i != out->count)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, names[i], "stands behind a gap");
    if (!t->name) return glbk__refuse(ctx, GLBK_ERR_DESC, function, names[i], "was not created");
    if (d->level >= t->levels)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.level", d->level, 0,
                                  (double)t->levels - 1);
    if (layer >= layers)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, is_color ? "desc.layer" : "desc.depth_layer",
                                  layer, 0, (double)layers - 1);
    if (is_color == glbk__is_depth(t->format))
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, names[i],
                            is_color ? "is a depth texture" : "is no depth texture");
    if (glbk__is_float(t->format) && !ctx->float_targets)
        return glbk__refuse(ctx, GLBK_ERR_FLOAT_TARGET, function, names[i],
                            "is of floats, which this context cannot draw to");
    if (out->width && (out->width != glbk__level_side(t->width, d->level) ||
                       out->height != glbk__level_side(t->height, d->level)))
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, names[i],
                            "is of another size than those before it");
    out->width = glbk__level_side(t->width, d->level);
    out->height = glbk__level_side(t->height, d->level);
    if (is_color) out->format[out->count++] = t->format;
    else out->has_depth = 1;
    return GLBK_OK;
}

static glbk_result glbk__check_target(const glbk_context *ctx, const glbk_target_desc *d, glbk_target *out)
{
    glbk_result result = GLBK_OK;
    uint32_t i;
    for (i = 0; i <= GLBK_MAX_ATTACHMENTS && result == GLBK_OK; i++)
        if (i < GLBK_MAX_ATTACHMENTS ? d->color[i] : d->depth)
            result = glbk__check_attachment(ctx, d, i, out);
    if (result != GLBK_OK || out->width) return result;
    return glbk__refuse(ctx, GLBK_ERR_DESC, "glbk_target_create", "desc", "has no attachment");
}

GLBK__DEF void glbk__attach(const glbk_context *ctx, uint32_t attachment, const glbk_texture *t,
                            uint32_t level, uint32_t layer)
{
    if (!t) return;
    if (t->layers)
        ctx->gl.FramebufferTextureLayer(GLBK_GL_DRAW_FRAMEBUFFER, attachment, t->name, (int32_t)level,
                                        (int32_t)layer);
    else
        ctx->gl.FramebufferTexture2D(GLBK_GL_DRAW_FRAMEBUFFER, attachment, t->gl_target, t->name,
                                     (int32_t)level);
}

/* Makes a framebuffer without colours complete: OpenGL 3.3 wants that no colour is to be read from it
   either; 4.1 dropped that rule. */
static void glbk__read_nothing(const glbk_context *ctx, uint32_t name)
{
    int32_t bound = 0;
    ctx->gl.GetIntegerv(GLBK__READ_FRAMEBUFFER_BINDING, &bound);
    ctx->gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, name);
    ctx->gl.ReadBuffer(GLBK__NONE);
    ctx->gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, (uint32_t)bound);
}

GLBK_DEF glbk_result glbk_target_create(glbk_context *ctx, const glbk_target_desc *desc, glbk_target *out)
{
    uint32_t buffers[GLBK_MAX_ATTACHMENTS], i, status;
    int32_t bound = 0;
    glbk_result result;

    result = glbk__enter_create(ctx, __func__, out, sizeof *out);
    if (result != GLBK_OK) return result;
    if (!desc) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "desc", "is NULL");
    result = glbk__check_target(ctx, desc, out);
    if (result != GLBK_OK) {
        memset(out, 0, sizeof *out);
        return result;
    }
    ctx->gl.GetIntegerv(GLBK__DRAW_FRAMEBUFFER_BINDING, &bound);
    ctx->gl.GenFramebuffers(1, &out->name);
    ctx->gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, out->name);
    for (i = 0; i < out->count; i++) {
        buffers[i] = GLBK_GL_COLOR_ATTACHMENT0 + i;
        glbk__attach(ctx, buffers[i], desc->color[i], desc->level, desc->layer[i]);
    }
    glbk__attach(ctx, GLBK_GL_DEPTH_ATTACHMENT, desc->depth, desc->level, desc->depth_layer);
    if (!out->count) {
        buffers[0] = GLBK__NONE;
        glbk__read_nothing(ctx, out->name);
    }
    ctx->gl.DrawBuffers(out->count ? (int32_t)out->count : 1, buffers);
    status = ctx->gl.CheckFramebufferStatus(GLBK_GL_DRAW_FRAMEBUFFER);
    ctx->gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, (uint32_t)bound);
    result = glbk__leave(ctx);
    if (result == GLBK_OK && status != GLBK__FRAMEBUFFER_COMPLETE) {
        glbk__log_constant(ctx, "glbk_target_create: framebuffer status ", status);
        result = GLBK_ERR_TARGET;
    }
    if (result != GLBK_OK) glbk_target_free(ctx, out);
    return result;
}

GLBK__DEF glbk_result glbk__target_create(glbk_context *ctx, const glbk_target_desc *desc, glbk_target *out)
{
    const glbk_result result = glbk_target_create(ctx, desc, out);
    if (result == GLBK_OK) out->inner = 1;
    return result;
}

/* Makes floats of bytes 0..255: `rgba` has room for count pixels of four floats, and the bytes stand at its
   end. */
static void glbk__bytes_to_floats(void *rgba, size_t count)
{
    const unsigned char *from = (const unsigned char *)rgba + 12 * count;
    float *to = (float *)rgba, pixel[4];
    size_t i, k;
    for (i = 0; i < count; i++) {       /* a pixel overwrites none that is still to come */
        for (k = 0; k < 4; k++) pixel[k] = (float)from[4 * i + k] / 255.0f;
        memcpy(to + 4 * i, pixel, sizeof pixel);
    }
}

GLBK_DEF glbk_result glbk_target_read(glbk_context *ctx, const glbk_target *target, uint32_t attachment,
                                      uint32_t x, uint32_t y, uint32_t width, uint32_t height, void *rgba)
{
    glbk__store store;
    int32_t bound = 0, clamp = 0;
    int integer, bytes;
    size_t count = (size_t)width * height;
    glbk_result result = glbk__enter(ctx);

    if (result != GLBK_OK) return result;
    if (!target || !target->name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "target", "was not created");
    if (!rgba) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "rgba", "is NULL");
    if (attachment >= target->count)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "attachment", attachment, 0,
                                  (double)target->count - 1);
    result = glbk__check_span(ctx, __func__, "x + width", (uint64_t)x + width, target->width);
    if (result == GLBK_OK)
        result = glbk__check_span(ctx, __func__, "y + height", (uint64_t)y + height, target->height);
    if (result != GLBK_OK) return result;
    integer = glbk__is_integer(target->format[attachment]);
    /* Of formats of bytes, ES gives no floats. */
    bytes = ctx->es && !integer && !glbk__is_float(target->format[attachment]);
    ctx->gl.GetIntegerv(GLBK__READ_FRAMEBUFFER_BINDING, &bound);
    ctx->gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, target->name);
    ctx->gl.ReadBuffer(GLBK_GL_COLOR_ATTACHMENT0 + attachment);
    glbk__store_begin(ctx, GLBK__PACK, &store);
    if (!ctx->es) {
        ctx->gl.GetIntegerv(GLBK__CLAMP_READ_COLOR, &clamp);
        ctx->gl.ClampColor(GLBK__CLAMP_READ_COLOR, GLBK__FALSE);
    }
    ctx->gl.ReadPixels((int32_t)x, (int32_t)y, (int32_t)width, (int32_t)height,
                       integer ? GLBK__RGBA_INTEGER : GLBK__RGBA,
                       integer ? GLBK_GL_UNSIGNED_INT
                       : bytes ? GLBK_GL_UNSIGNED_BYTE
                               : GLBK_GL_FLOAT,
                       (unsigned char *)rgba + (bytes ? 12 * count : 0));
    if (!ctx->es) ctx->gl.ClampColor(GLBK__CLAMP_READ_COLOR, (uint32_t)clamp);
    glbk__store_end(ctx, GLBK__PACK, &store);
    ctx->gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, (uint32_t)bound);
    result = glbk__leave(ctx);
    if (result == GLBK_OK && bytes) glbk__bytes_to_floats(rgba, count);
    return result;
}

GLBK_DEF void glbk_target_free(glbk_context *ctx, glbk_target *target)
{
    if (!target) return;
    if (ctx && !ctx->lost && target->name) ctx->gl.DeleteFramebuffers(1, &target->name);
    if (ctx && ctx->inner == target->name) ctx->inner = 0;
    memset(target, 0, sizeof *target);
}

/* ==== src/gl/state.h ==== */

/* ---- state: what passes touch ---- */

/* Capabilities: GL's name and constant, where there is such a capability, and the value that a pass needs.
   BOTH are in both dialects, DESK in OpenGL alone. PROGRAM_POINT_SIZE, MULTISAMPLE and
   TEXTURE_CUBE_MAP_SEAMLESS are on, because ES has no switch for them and behaves so; the others must not
   interfere. FRAMEBUFFER_SRGB is for targets alone that have such a format, which ES encodes, too: the user
   decides about other framebuffers. */
#define GLBK__COMMON_CAPS(X)                                                                            \
    X(BLEND, 0x0BE2, BOTH, 0) X(DEPTH_TEST, 0x0B71, BOTH, 0) X(CULL_FACE, 0x0B44, BOTH, 0)              \
    X(POLYGON_OFFSET_FILL, 0x8037, BOTH, 0) X(SCISSOR_TEST, 0x0C11, BOTH, 0)                            \
    X(STENCIL_TEST, 0x0B90, BOTH, 0) X(DITHER, 0x0BD0, BOTH, 0)                                         \
    X(SAMPLE_ALPHA_TO_COVERAGE, 0x809E, BOTH, 0) X(SAMPLE_COVERAGE, 0x80A0, BOTH, 0)                    \
    X(RASTERIZER_DISCARD, 0x8C89, BOTH, 0) X(PRIMITIVE_RESTART_FIXED_INDEX, 0x8D69, RESTART, 0)
#define GLBK__DESK_CAPS(X)                                                                              \
    X(PRIMITIVE_RESTART, 0x8F9D, DESK, 0) X(COLOR_LOGIC_OP, 0x0BF2, DESK, 0)                            \
    X(DEPTH_CLAMP, 0x864F, DESK, 0) X(SAMPLE_ALPHA_TO_ONE, 0x809F, DESK, 0)                             \
    X(SAMPLE_MASK, 0x8E51, DESK, 0) X(POLYGON_SMOOTH, 0x0B41, DESK, 0) X(LINE_SMOOTH, 0x0B20, DESK, 0)  \
    X(POLYGON_OFFSET_LINE, 0x2A02, DESK, 0) X(POLYGON_OFFSET_POINT, 0x2A01, DESK, 0)                    \
    X(PROGRAM_POINT_SIZE, 0x8642, DESK, 1) X(MULTISAMPLE, 0x809D, DESK, 1)                              \
    X(FRAMEBUFFER_SRGB, 0x8DB9, SRGB, 1) X(TEXTURE_CUBE_MAP_SEAMLESS, 0x884F, DESK, 1)
#define GLBK__CLIP_CAPS(X)                                                                              \
    X(CLIP_DISTANCE0, 0x3000, DESK, 0) X(CLIP_DISTANCE1, 0x3001, DESK, 0)                               \
    X(CLIP_DISTANCE2, 0x3002, DESK, 0) X(CLIP_DISTANCE3, 0x3003, DESK, 0)                               \
    X(CLIP_DISTANCE4, 0x3004, DESK, 0) X(CLIP_DISTANCE5, 0x3005, DESK, 0)                               \
    X(CLIP_DISTANCE6, 0x3006, DESK, 0) X(CLIP_DISTANCE7, 0x3007, DESK, 0)
#define GLBK__CAPS(X) GLBK__COMMON_CAPS(X) GLBK__DESK_CAPS(X) GLBK__CLIP_CAPS(X)

enum {
    GLBK__CAP_BOTH, GLBK__CAP_DESK, GLBK__CAP_RESTART, GLBK__CAP_SRGB,
#define GLBK__ENTRY(name, gl, group, value) GLBK__##name = gl,
    GLBK__CAPS(GLBK__ENTRY)
#undef GLBK__ENTRY
};

static const struct { uint16_t name; uint8_t group, value; } glbk__caps[] = {
#define GLBK__ENTRY(name, gl, group, value) { gl, GLBK__CAP_##group, value },
    GLBK__CAPS(GLBK__ENTRY)
#undef GLBK__ENTRY
};
enum { GLBK__CAP_COUNT = sizeof glbk__caps / sizeof glbk__caps[0] };

static int glbk__has_cap(const glbk_context *ctx, int i)
{
    if (glbk__caps[i].group == GLBK__CAP_RESTART)
        return ctx->es ? !ctx->webgl : ctx->version >= 430;     /* WebGL has no switch: primitives restart */
    return glbk__caps[i].group == GLBK__CAP_BOTH || !ctx->es;
}

GLBK__DEF void glbk__set_cap(const glbk_context *ctx, uint32_t name, int on)
{
    if (on) ctx->gl.Enable(name);
    else ctx->gl.Disable(name);
}

/* Whole numbers: GL's name for asking, and the one that GLBK__W_ is followed by. */
#define GLBK__WORDS(X)                                                                                  \
    X(PROGRAM, GLBK__CURRENT_PROGRAM_NAME) X(VERTEX_ARRAY, GLBK__VERTEX_ARRAY_BINDING)                  \
    X(TARGET, GLBK__DRAW_FRAMEBUFFER_BINDING) X(UNIT, GLBK__ACTIVE_TEXTURE)                             \
    X(BLOCK, GLBK__UNIFORM_BUFFER_BINDING) X(DEPTH_FUNC, GLBK__DEPTH_FUNC)                              \
    X(CULL_MODE, GLBK__CULL_FACE_MODE) X(FRONT, GLBK__FRONT_FACE)                                       \
    X(SOURCE_RGB, GLBK__BLEND_SRC_RGB) X(DEST_RGB, GLBK__BLEND_DST_RGB)                                 \
    X(SOURCE_ALPHA, GLBK__BLEND_SRC_ALPHA) X(DEST_ALPHA, GLBK__BLEND_DST_ALPHA)                         \
    X(EQUATION_RGB, GLBK__BLEND_EQUATION_RGB) X(EQUATION_ALPHA, GLBK__BLEND_EQUATION_ALPHA)

enum {
    GLBK__CURRENT_PROGRAM_NAME = 0x8B8D,
    GLBK__VERTEX_ARRAY_BINDING = 0x85B5,
    GLBK__ACTIVE_TEXTURE = 0x84E0,
    GLBK__DEPTH_FUNC = 0x0B74,
    GLBK__CULL_FACE_MODE = 0x0B45,
    GLBK__FRONT_FACE = 0x0B46,
    GLBK__BLEND_SRC_RGB = 0x80C9,
    GLBK__BLEND_DST_RGB = 0x80C8,
    GLBK__BLEND_SRC_ALPHA = 0x80CB,
    GLBK__BLEND_DST_ALPHA = 0x80CA,
    GLBK__BLEND_EQUATION_RGB = 0x8009,
    GLBK__BLEND_EQUATION_ALPHA = 0x883D,
    GLBK__COLOR_WRITEMASK = 0x0C23,
    GLBK__SAMPLER_BINDING = 0x8919,
    GLBK__UNIFORM_BUFFER_BINDING = 0x8A28,
    GLBK__UNIFORM_BUFFER_START = 0x8A29,
    GLBK__UNIFORM_BUFFER_BYTES = 0x8A2A /* UNIFORM_BUFFER_SIZE */,
    GLBK__STORAGE_BUFFER_BINDING = 0x90D3,
    GLBK__STORAGE_BUFFER_START = 0x90D4,
    GLBK__STORAGE_BUFFER_BYTES = 0x90D5,
    GLBK__DISPATCH_INDIRECT_BUFFER_BINDING = 0x90EF,
    GLBK__IMAGE_BINDING_NAME = 0x8F3A,
    GLBK__IMAGE_BINDING_LEVEL = 0x8F3B,
    GLBK__IMAGE_BINDING_LAYERED = 0x8F3C,
    GLBK__IMAGE_BINDING_LAYER = 0x8F3D,
    GLBK__IMAGE_BINDING_ACCESS = 0x8F3E,
    GLBK__IMAGE_BINDING_FORMAT = 0x906E,
    GLBK__POLYGON_MODE = 0x0B40,
    GLBK__FRONT_AND_BACK = 0x0408,
    GLBK__FILL = 0x1B02,
    GLBK__VIEWPORT = 0x0BA2,
    GLBK__DEPTH_WRITEMASK = 0x0B72,
    GLBK__DEPTH_RANGE = 0x0B70,
    GLBK__POLYGON_OFFSET_FACTOR = 0x8038,
    GLBK__POLYGON_OFFSET_UNITS = 0x2A00,
    GLBK__POLYGON_OFFSET_CLAMP = 0x8E1B
};

enum {
#define GLBK__ENTRY(name, gl) GLBK__W_##name,
    GLBK__WORDS(GLBK__ENTRY)
#undef GLBK__ENTRY
    GLBK__WORD_COUNT,
    GLBK__W_STORAGE = GLBK__WORD_COUNT, GLBK__W_GROUPS, GLBK__W_ORIGIN, GLBK__W_CLIP_DEPTH, GLBK__W_POLYGON,
    GLBK__W_POLYGON_2
};

static const uint16_t glbk__word_names[] = {
#define GLBK__ENTRY(name, gl) gl,
    GLBK__WORDS(GLBK__ENTRY)
#undef GLBK__ENTRY
};

enum { GLBK__BLEND_WORDS = 6 };     /* the words from SOURCE_RGB to EQUATION_ALPHA */

static void glbk__save_indexed(glbk_context *ctx, glbk_state *s)
{
    uint32_t i, k;
    if (!ctx->each_target) {
        ctx->gl.GetBooleanv(GLBK__COLOR_WRITEMASK, s->color_mask[0]);
        return;
    }
    for (i = 0; i < ctx->max_targets; i++) {
        s->blend[i] = ctx->gl.IsEnabledi(GLBK__BLEND, i);
        ctx->gl.GetBooleani_v(GLBK__COLOR_WRITEMASK, i, s->color_mask[i]);
        for (k = 0; k < GLBK__BLEND_WORDS && ctx->each_blend; k++)
            ctx->gl.GetIntegeri_v(glbk__word_names[GLBK__W_SOURCE_RGB + k], i, &s->blends[i][k]);
    }
}

static const uint16_t glbk__image_names[6] = { GLBK__IMAGE_BINDING_NAME,    GLBK__IMAGE_BINDING_LEVEL,
                                               GLBK__IMAGE_BINDING_LAYERED, GLBK__IMAGE_BINDING_LAYER,
                                               GLBK__IMAGE_BINDING_ACCESS,  GLBK__IMAGE_BINDING_FORMAT };

static void glbk__save_images(glbk_context *ctx, glbk_state *s)
{
    uint32_t i, k;
    for (i = 0; i < GLBK_IMAGES; i++)
        for (k = 0; k < 6; k++) ctx->gl.GetIntegeri_v(glbk__image_names[k], i, &s->images[i][k]);
}

static void glbk__restore_images(glbk_context *ctx, const glbk_state *s)
{
    uint32_t i;
    for (i = 0; i < GLBK_IMAGES; i++) {
        const int32_t *m = s->images[i];
        ctx->gl.BindImageTexture(i, (uint32_t)m[0], m[1], (uint8_t)(m[2] != 0), m[3], (uint32_t)m[4],
                                 (uint32_t)m[5]);
    }
}

static void glbk__save_bindings(glbk_context *ctx, glbk_state *s)
{
    uint32_t i;
    for (i = 0; i < ctx->unit_count; i++) {
        ctx->gl.ActiveTexture(GLBK_GL_TEXTURE0 + ctx->first_unit + i);
        ctx->gl.GetIntegerv(GLBK__TEXTURE_BINDING_2D, &s->units[i][0]);
        ctx->gl.GetIntegerv(GLBK__TEXTURE_BINDING_2D_ARRAY, &s->units[i][1]);
        ctx->gl.GetIntegerv(GLBK__SAMPLER_BINDING, &s->units[i][2]);
    }
    ctx->gl.ActiveTexture((uint32_t)s->words[GLBK__W_UNIT]);
    for (i = 0; i < ctx->block_count; i++) {
        ctx->gl.GetIntegeri_v(GLBK__UNIFORM_BUFFER_BINDING, ctx->first_block + i, &s->blocks[i]);
        ctx->gl.GetInteger64i_v(GLBK__UNIFORM_BUFFER_START, ctx->first_block + i, &s->ranges[i][0]);
        ctx->gl.GetInteger64i_v(GLBK__UNIFORM_BUFFER_BYTES, ctx->first_block + i, &s->ranges[i][1]);
    }
    for (i = 0; i < GLBK_BLOCKS && ctx->compute; i++) {
        ctx->gl.GetIntegeri_v(GLBK__STORAGE_BUFFER_BINDING, i, &s->storage[i]);
        ctx->gl.GetInteger64i_v(GLBK__STORAGE_BUFFER_START, i, &s->storage_ranges[i][0]);
        ctx->gl.GetInteger64i_v(GLBK__STORAGE_BUFFER_BYTES, i, &s->storage_ranges[i][1]);
    }
}

GLBK_DEF void glbk_state_save(glbk_context *ctx, glbk_state *out)
{
    int i;
    if (!out) return;
    memset(out, 0, sizeof *out);
    if (!ctx || ctx->lost) return;
    for (i = 0; i < GLBK__CAP_COUNT; i++)
        if (glbk__has_cap(ctx, i)) out->caps[i] = ctx->gl.IsEnabled(glbk__caps[i].name);
    for (i = 0; i < GLBK__WORD_COUNT; i++) ctx->gl.GetIntegerv(glbk__word_names[i], &out->words[i]);
    if (ctx->compute) {
        ctx->gl.GetIntegerv(GLBK__STORAGE_BUFFER_BINDING, &out->words[GLBK__W_STORAGE]);
        ctx->gl.GetIntegerv(GLBK__DISPATCH_INDIRECT_BUFFER_BINDING, &out->words[GLBK__W_GROUPS]);
        glbk__save_images(ctx, out);
    }
    if (ctx->clip_control) {
        ctx->gl.GetIntegerv(GLBK__CLIP_ORIGIN, &out->words[GLBK__W_ORIGIN]);
        ctx->gl.GetIntegerv(GLBK__CLIP_DEPTH_MODE, &out->words[GLBK__W_CLIP_DEPTH]);
    }
    if (!ctx->es) ctx->gl.GetIntegerv(GLBK__POLYGON_MODE, &out->words[GLBK__W_POLYGON]);    /* writes two */
    ctx->gl.GetIntegerv(GLBK__VIEWPORT, out->viewport);
    ctx->gl.GetBooleanv(GLBK__DEPTH_WRITEMASK, &out->depth_mask);
    ctx->gl.GetFloatv(GLBK__DEPTH_RANGE, out->floats);
    ctx->gl.GetFloatv(GLBK__POLYGON_OFFSET_FACTOR, out->floats + 2);
    ctx->gl.GetFloatv(GLBK__POLYGON_OFFSET_UNITS, out->floats + 3);
    if (ctx->offset_clamp) ctx->gl.GetFloatv(GLBK__POLYGON_OFFSET_CLAMP, &out->offset_clamp);
    glbk__save_indexed(ctx, out);
    glbk__save_bindings(ctx, out);
}

static void glbk__restore_indexed(glbk_context *ctx, const glbk_state *s)
{
    const uint8_t(*mask)[4] = s->color_mask;
    uint32_t i;
    if (!ctx->each_target) {
        ctx->gl.ColorMask(mask[0][0], mask[0][1], mask[0][2], mask[0][3]);
        return;
    }
    for (i = 0; i < ctx->max_targets; i++) {
        const int32_t *b = s->blends[i];
        if (s->blend[i]) ctx->gl.Enablei(GLBK__BLEND, i);
        else ctx->gl.Disablei(GLBK__BLEND, i);
        ctx->gl.ColorMaski(i, mask[i][0], mask[i][1], mask[i][2], mask[i][3]);
        if (!ctx->each_blend) continue;
        ctx->gl.BlendFuncSeparatei(i, (uint32_t)b[0], (uint32_t)b[1], (uint32_t)b[2], (uint32_t)b[3]);
        ctx->gl.BlendEquationSeparatei(i, (uint32_t)b[4], (uint32_t)b[5]);
    }
}

static void glbk__restore_range(glbk_context *ctx, uint32_t target, uint32_t index, int32_t name,
                                const int64_t range[2])
{
    if (name && range[1])
        ctx->gl.BindBufferRange(target, index, (uint32_t)name, (ptrdiff_t)range[0], (ptrdiff_t)range[1]);
    else ctx->gl.BindBufferBase(target, index, (uint32_t)name);
}

static void glbk__restore_bindings(glbk_context *ctx, const glbk_state *s)
{
    uint32_t i;
    for (i = 0; i < ctx->unit_count; i++) {
        ctx->gl.ActiveTexture(GLBK_GL_TEXTURE0 + ctx->first_unit + i);
        ctx->gl.BindTexture(GLBK_GL_TEXTURE_2D, (uint32_t)s->units[i][0]);
        ctx->gl.BindTexture(GLBK_GL_TEXTURE_2D_ARRAY, (uint32_t)s->units[i][1]);
        ctx->gl.BindSampler(ctx->first_unit + i, (uint32_t)s->units[i][2]);
    }
    ctx->gl.ActiveTexture((uint32_t)s->words[GLBK__W_UNIT]);
    for (i = 0; i < ctx->block_count; i++)
        glbk__restore_range(ctx, GLBK_GL_UNIFORM_BUFFER, ctx->first_block + i, s->blocks[i], s->ranges[i]);
    for (i = 0; i < GLBK_BLOCKS && ctx->compute; i++)
        glbk__restore_range(ctx, GLBK_GL_SHADER_STORAGE_BUFFER, i, s->storage[i], s->storage_ranges[i]);
    ctx->gl.BindBuffer(GLBK_GL_UNIFORM_BUFFER, (uint32_t)s->words[GLBK__W_BLOCK]);
    if (!ctx->compute) return;
    ctx->gl.BindBuffer(GLBK_GL_SHADER_STORAGE_BUFFER, (uint32_t)s->words[GLBK__W_STORAGE]);
    ctx->gl.BindBuffer(GLBK_GL_DISPATCH_INDIRECT_BUFFER, (uint32_t)s->words[GLBK__W_GROUPS]);
    glbk__restore_images(ctx, s);
}

static void glbk__depth_range(const glbk_context *ctx, float from, float to)
{
    if (ctx->es) ctx->gl.DepthRangef(from, to);
    else ctx->gl.DepthRange((double)from, (double)to);
}

GLBK_DEF void glbk_state_restore(glbk_context *ctx, const glbk_state *state)
{
    const int32_t *w;
    int i;
    if (!ctx || ctx->lost || !state) return;
    w = state->words;
    for (i = 0; i < GLBK__CAP_COUNT; i++)
        if (glbk__has_cap(ctx, i)) glbk__set_cap(ctx, glbk__caps[i].name, state->caps[i]);
    /* A program that its owner deleted while it was in use went away with the first glUseProgram. */
    ctx->gl.UseProgram(ctx->gl.IsProgram((uint32_t)w[GLBK__W_PROGRAM]) ? (uint32_t)w[GLBK__W_PROGRAM] : 0);
    ctx->gl.BindVertexArray((uint32_t)w[GLBK__W_VERTEX_ARRAY]);
    ctx->gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, (uint32_t)w[GLBK__W_TARGET]);
    ctx->gl.DepthFunc((uint32_t)w[GLBK__W_DEPTH_FUNC]);
    ctx->gl.CullFace((uint32_t)w[GLBK__W_CULL_MODE]);
    ctx->gl.FrontFace((uint32_t)w[GLBK__W_FRONT]);
    ctx->gl.BlendFuncSeparate((uint32_t)w[GLBK__W_SOURCE_RGB], (uint32_t)w[GLBK__W_DEST_RGB],
                              (uint32_t)w[GLBK__W_SOURCE_ALPHA], (uint32_t)w[GLBK__W_DEST_ALPHA]);
    ctx->gl.BlendEquationSeparate((uint32_t)w[GLBK__W_EQUATION_RGB], (uint32_t)w[GLBK__W_EQUATION_ALPHA]);
    if (ctx->clip_control) ctx->gl.ClipControl((uint32_t)w[GLBK__W_ORIGIN], (uint32_t)w[GLBK__W_CLIP_DEPTH]);
    if (!ctx->es) ctx->gl.PolygonMode(GLBK__FRONT_AND_BACK, (uint32_t)w[GLBK__W_POLYGON]);
    ctx->gl.Viewport(state->viewport[0], state->viewport[1], state->viewport[2], state->viewport[3]);
    ctx->gl.DepthMask(state->depth_mask);
    glbk__depth_range(ctx, state->floats[0], state->floats[1]);
    if (ctx->offset_clamp)
        ctx->gl.PolygonOffsetClamp(state->floats[2], state->floats[3], state->offset_clamp);
    else
        ctx->gl.PolygonOffset(state->floats[2], state->floats[3]);
    glbk__restore_indexed(ctx, state);
    glbk__restore_bindings(ctx, state);
}

/* ==== src/gl/passes.h ==== */

/* ---- passes: what is drawn to, by which program, from which textures and buffers ---- */

enum {
    GLBK__LESS = 0x0201, GLBK__EQUAL = 0x0202, GLBK__GREATER = 0x0204, GLBK__ALWAYS = 0x0207,
    GLBK__FUNC_ADD = 0x8006, GLBK__MIN = 0x8007, GLBK__MAX = 0x8008, GLBK__ONE = 1,
    GLBK__SRC_ALPHA = 0x0302, GLBK__ONE_MINUS_SRC_ALPHA = 0x0303,
    GLBK__FRONT = 0x0404, GLBK__BACK = 0x0405, GLBK__CCW = 0x0901, GLBK__READ_WRITE = 0x88BA
};

static void glbk__set_depth(const glbk_context *ctx, glbk_depth depth)
{
    static const uint32_t functions[] = { GLBK__ALWAYS, GLBK__LESS, GLBK__LEQUAL, GLBK__EQUAL,
                                          GLBK__GREATER };
    glbk__set_cap(ctx, GLBK__DEPTH_TEST, depth != GLBK_DEPTH_OFF);
    ctx->gl.DepthMask(depth != GLBK_DEPTH_OFF && depth != GLBK_DEPTH_EQUAL);
    ctx->gl.DepthFunc(functions[depth]);
}

static void glbk__set_blend(const glbk_context *ctx, glbk_blend blend)
{
    static const uint32_t equations[] = { GLBK__FUNC_ADD, GLBK__FUNC_ADD, GLBK__MIN, GLBK__MAX,
                                          GLBK__FUNC_ADD };
    if (blend == GLBK_BLEND_OFF) return;
    ctx->gl.Enable(GLBK__BLEND);
    ctx->gl.BlendEquationSeparate(equations[blend], equations[blend]);
    if (blend == GLBK_BLEND_OVER)
        ctx->gl.BlendFuncSeparate(GLBK__SRC_ALPHA, GLBK__ONE_MINUS_SRC_ALPHA, GLBK__ONE,
                                  GLBK__ONE_MINUS_SRC_ALPHA);
    else ctx->gl.BlendFuncSeparate(GLBK__ONE, GLBK__ONE, GLBK__ONE, GLBK__ONE);
}

static void glbk__set_cull(const glbk_context *ctx, glbk_cull cull)
{
    ctx->gl.FrontFace(GLBK__CCW);
    if (cull == GLBK_CULL_OFF) return;
    ctx->gl.Enable(GLBK__CULL_FACE);
    ctx->gl.CullFace(cull == GLBK_CULL_BACK ? GLBK__BACK : GLBK__FRONT);
}

static int glbk__has_srgb(const glbk_target *target)
{
    uint32_t i;
    for (i = 0; target && i < target->count; i++)
        if (target->format[i] == GLBK_FORMAT_SRGB8_A8) return 1;
    return 0;
}

static glbk_result glbk__check_pass(const glbk_context *ctx, const glbk_pass *pass)
{
    static const char function[] = "glbk_begin";
    const int32_t *v = pass->viewport;
    if ((unsigned)pass->depth >= GLBK_DEPTH_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "pass.depth", (double)pass->depth,
                                  "a glbk_depth");
    if ((unsigned)pass->blend >= GLBK_BLEND_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "pass.blend", (double)pass->blend,
                                  "a glbk_blend");
    if ((unsigned)pass->cull >= GLBK_CULL_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "pass.cull", (double)pass->cull,
                                  "a glbk_cull");
    if (pass->target && !pass->target->name)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "pass.target", "was not created");
    if (v[2] < 0 || v[3] < 0)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function,
                                  v[2] < 0 ? "pass.viewport[2]" : "pass.viewport[3]", v[2] < 0 ? v[2] : v[3],
                                  "0 or more");
    if (!pass->target && (!v[2] || !v[3]))
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, v[2] ? "pass.viewport[3]" : "pass.viewport[2]",
                            "is 0, and there is no pass.target whose size it could be");
    return GLBK_OK;
}

GLBK_DEF void glbk_program_use(glbk_context *ctx, glbk_program *program)
{
    if (!ctx || ctx->lost || !program) return;
    ctx->gl.UseProgram(program->name);
    ctx->program = program->name;
    if (program->slots_fn) program->slots_fn(ctx, program);
    program->slots_fn = NULL;
}

GLBK_DEF glbk_result glbk_begin(glbk_context *ctx, const glbk_pass *pass, glbk_program *program)
{
    const int32_t *v;
    glbk_result result;
    uint8_t color;
    int i;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!pass) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "pass", "is NULL");
    result = glbk__check_pass(ctx, pass);
    if (result != GLBK_OK) return result;
    if (ctx->lost) return GLBK_ERR_LOST;
    v = pass->viewport;

    for (i = 0; i < GLBK__CAP_COUNT; i++)
        if (glbk__has_cap(ctx, i) && (glbk__caps[i].group != GLBK__CAP_SRGB || glbk__has_srgb(pass->target)))
            glbk__set_cap(ctx, glbk__caps[i].name, glbk__caps[i].value);
    if (pass->target) {
        ctx->gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, pass->target->name);
        ctx->inner = pass->target->inner ? pass->target->name : 0;
    }
    if (v[2] || v[3]) ctx->gl.Viewport(v[0], v[1], v[2], v[3]);
    else ctx->gl.Viewport(0, 0, (int32_t)pass->target->width, (int32_t)pass->target->height);
    glbk__set_depth(ctx, pass->depth);
    glbk__set_blend(ctx, pass->blend);
    glbk__set_cull(ctx, pass->cull);
    color = !pass->no_color;
    ctx->gl.ColorMask(color, color, color, color);
    glbk__depth_range(ctx, 0, 1);
    if (pass->offset[0] != 0 || pass->offset[1] != 0) {
        ctx->gl.Enable(GLBK__POLYGON_OFFSET_FILL);
        ctx->gl.PolygonOffset(pass->offset[0], pass->offset[1]);
    }
    if (!ctx->es) ctx->gl.PolygonMode(GLBK__FRONT_AND_BACK, GLBK__FILL);
    if (ctx->clip_control) ctx->gl.ClipControl(GLBK__LOWER_LEFT, GLBK__NEGATIVE_ONE_TO_ONE);
    ctx->gl.BindVertexArray(ctx->vertex_array);
    glbk_program_use(ctx, program);
    return GLBK_OK;
}

GLBK_DEF void glbk_clear(glbk_context *ctx, const glbk_target *target, uint32_t attachment,
                         const float rgba[4])
{
    if (!ctx || ctx->lost || !target || attachment >= target->count || !rgba) return;
    if (glbk__is_integer(target->format[attachment])) {
        uint32_t words[4];
        int i;
        if (target->format[attachment] == GLBK_FORMAT_RGBA32UI && !ctx->float_targets) {
            memcpy(words, rgba, sizeof words);      /* the bits of the floats */
        } else {
            for (i = 0; i < 4; i++)
                words[i] = rgba[i] > 0
                               ? (uint32_t)(rgba[i] < 4294967296.0f ? (double)rgba[i] + 0.5 : 4294967295.0)
                               : 0;
        }
        ctx->gl.ClearBufferuiv(GLBK_GL_COLOR, (int32_t)attachment, words);
    } else {
        ctx->gl.ClearBufferfv(GLBK_GL_COLOR, (int32_t)attachment, rgba);
    }
}

GLBK_DEF void glbk_clear_depth(glbk_context *ctx, float depth)
{
    if (ctx && !ctx->lost) ctx->gl.ClearBufferfv(GLBK_GL_DEPTH, 0, &depth);
}

GLBK_DEF void glbk_bind_texture(glbk_context *ctx, uint32_t slot, const glbk_texture *texture)
{
    if (!ctx || ctx->lost || slot >= ctx->unit_count) return;
    ctx->gl.ActiveTexture(GLBK_GL_TEXTURE0 + ctx->first_unit + slot);
    if (texture && texture->name) {
        ctx->gl.BindTexture(texture->gl_target, texture->name);
    } else {
        ctx->gl.BindTexture(GLBK_GL_TEXTURE_2D, 0);
        ctx->gl.BindTexture(GLBK_GL_TEXTURE_2D_ARRAY, 0);
    }
    ctx->gl.BindSampler(ctx->first_unit + slot, 0);
}

GLBK_DEF void glbk_bind_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer)
{
    if (!ctx || ctx->lost || !buffer || slot >= ctx->block_count) return;
    ctx->gl.BindBufferBase(GLBK_GL_UNIFORM_BUFFER, ctx->first_block + slot, buffer->name);
}

GLBK_DEF void glbk_bind_storage(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer)
{
    if (!ctx || ctx->lost || !ctx->compute || !buffer || slot >= GLBK_BLOCKS) return;
    ctx->gl.BindBufferBase(GLBK_GL_SHADER_STORAGE_BUFFER, slot, buffer->name);
}

GLBK_DEF void glbk_bind_image(glbk_context *ctx, uint32_t slot, const glbk_texture *texture)
{
    if (!ctx || ctx->lost || !ctx->compute || !texture || !texture->name || slot >= GLBK_IMAGES) return;
    ctx->gl.BindImageTexture(slot, texture->name, 0, texture->layers != 0, 0, GLBK__READ_WRITE,
                             (uint32_t)glbk__formats[texture->format].internal);
}

GLBK_DEF void glbk_draw_screen(glbk_context *ctx)
{
    if (ctx && !ctx->lost) ctx->gl.DrawArrays(GLBK_GL_TRIANGLES, 0, 3);
}

/* ==== src/gl/end.h ==== */

#endif /* GL_BACKEND_IMPLEMENTATION */

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
