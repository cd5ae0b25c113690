/* gl_backend.h - v0.1.0 - Dapple's techniques on OpenGL 3.3, OpenGL ES 3.0 and WebGL 2 - MIT-0 OR Unlicense

   What it does

   Brings what the other headers build onto the GPU: uploads as plain textures, GLSL functions to paste into your own
   shaders with a call that binds what they need, and complete passes. Underneath lies a small layer that you may use
   by itself: GL functions without a loader, programs from the embedded GLSL, textures, targets, passes, state.

   What it does not do

   - No window, no context: make one (GLFW, EGL, SDL, Emscripten, ...) and make it current. OpenGL 3.3 core, ES 3.0 or
     more. The core path has no geometry shaders, texture buffers or compute; with 4.3 a compute path is used as well.
   - It needs none of the other headers: their data comes in as bytes and arrays.
   - Not inside an active transform feedback, query of the same kind or conditional rendering of yours.
   - It has no cache of GL state and assumes none: what it needs it sets, what it sets docs/gl-state.md lists.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #include "gl_backend.h"
       #include <stdio.h>

       // With GLFW: return glfwGetProcAddress(name);  with EGL: return eglGetProcAddress(name);
       static glbk_proc get_proc(const char *name, void *user)
       {
           (void)name; (void)user;
           return NULL;                                     // no GL here: init says so below
       }

       int main(void)
       {
           glbk_context gl;
           glbk_desc desc = { 0 };
           char log[1000];
           glbk_result result;

           desc.get_proc = get_proc;                        // a context is current
           desc.log = log;
           desc.log_size = sizeof log;
           result = glbk_init(&gl, &desc);
           if (result != GLBK_OK) {
               printf("no GL: %s (%s)\n", glbk_result_text(result), log);
               return result != GLBK_ERR_FUNCTION;
           }
           printf("GL %d on %s\n", gl.version, gl.renderer);
           glbk_destroy(&gl);
           return 0;
       }

   A picture drawn by a shader of your own that calls a function of the library: examples/09_gl_minimal.c.

   Conventions

   Matrices column-major float[16]; GL names are uint32_t; rows of textures from the bottom up, as GL has them. Clip
   depth is GL's -1..1: passes set it back where a context has clip control.

     file       a piece of GLSL in this header: a library file (functions) or a program's main
     set        defines that a program is compiled with: "FILTER=1 COUNT=4"
     slot       number of a texture unit, uniform block or buffer as the lists of bindings give it; the context adds
                desc.first_unit and desc.first_block
     table      an array of texels, addressed by one number: a 2D array texture 1024 wide and 1024 high
     target     a framebuffer object with the sizes and formats of what is attached
     pass       what GL must be set to before something is drawn

   How it works

   All GL functions come from your get_proc and are kept in the context object: several contexts live side by side, no
   GL header and no link against GL is needed. What exists is decided by version and extension strings, not by whether
   get_proc returns something. GLSL is kept as arrays of lines, one for each file under src/shaders; a program is
   version line, defines, lib/prelude.glsl, the library files that it names, and its own. One text serves 330 core and
   300 es. Names, units and block layouts come from one list (GLBK_PARTS) that C, GLSL and the tests share.

   Floats on ES 3.0 and WebGL 2 are renderable with EXT_color_buffer_float only. Without it a target of format
   GLBK_FORMAT_COLOR holds the bits of floats in integers, and lib/prelude.glsl hides the difference (glbk_color).

   Configuration

     GL_BACKEND_IMPLEMENTATION   in one source file: compiles the code
     GL_BACKEND_STATIC           everywhere it is included: a private copy, all functions static
     GLBK_DEF                    everywhere: your own linkage instead
     GLBK_ASSERT(x)              with the implementation: in place of assert

   Memory, errors, threads, determinism

   Memory comes from the allocator in the desc, only while a program is compiled and by calls that say so. Every
   function that can fail returns a glbk_result; where it is not GLBK_OK its outputs are zeroed, GL objects made on the
   way are deleted, and the log that you gave holds the driver's words or the name of what is missing. Creating calls
   refuse to start while a GL error is pending (GLBK_ERR_PENDING), so none of yours gets lost or blamed on us.
   Creating, updating, reading and destroying leave every GL state as they found it; passes change what
   docs/gl-state.md lists, and glbk_state_save and glbk_state_restore bring it back. Objects are destroyed explicitly;
   destroying accepts zeroed and half-built objects and, after glbk_abandon or GLBK_ERR_LOST, calls no GL.
   A context and its objects belong to the thread where the GL context is current. No globals.

   Cost: docs/performance.md.   State: docs/gl-state.md.   History: CHANGELOG.md.   Licence: end of this file. */
#ifndef GL_BACKEND_H
#define GL_BACKEND_H

#define GLBK_VERSION 100 /* major * 10000 + minor * 100 + patch */

#include <stddef.h>
#include <stdint.h>

#ifndef GLBK_DEF
#ifdef GL_BACKEND_STATIC
#define GLBK_DEF static inline
#else
#define GLBK_DEF extern
#endif
#endif

#if defined(_WIN32) && !defined(_WIN64)
#define GLBK_CALL __stdcall
#else
#define GLBK_CALL
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- results ---- */

#define GLBK_RESULTS(X)                                                                                     \
    X(GLBK_OK, "ok")                                                                                        \
    X(GLBK_ERR_ARGUMENT, "an argument is NULL, zero or out of range")                                       \
    X(GLBK_ERR_CONTEXT, "no GL context is current")                                                         \
    X(GLBK_ERR_VERSION, "the context is older than OpenGL 3.3 or OpenGL ES 3.0")                            \
    X(GLBK_ERR_FUNCTION, "a GL function is missing")                                                        \
    X(GLBK_ERR_FEATURE, "this call needs OpenGL 4.3 (compute)")                                             \
    X(GLBK_ERR_FLOAT_TARGET, "rendering to this float format needs EXT_color_buffer_float")                 \
    X(GLBK_ERR_LIMIT, "a size passes a limit of this context")                                              \
    X(GLBK_ERR_NAME, "no GLSL file of that name")                                                           \
    X(GLBK_ERR_COMPILE, "a shader does not compile")                                                        \
    X(GLBK_ERR_LINK, "a program does not link")                                                             \
    X(GLBK_ERR_TARGET, "the driver cannot render to this combination of formats")                           \
    X(GLBK_ERR_ALLOC, "the allocator returned no memory")                                                   \
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

GLBK_DEF const char *glbk_result_text(glbk_result result);
/* A constant string for any value, "unknown result" beyond the list. */

/* ---- GL itself: functions without the gl prefix, constants ----

   X(group, return type, name, parameters). Groups: CORE is in OpenGL 3.3 and ES 3.0 alike; DESK in OpenGL 3.3 only, ES
   in ES only; the others from the version on that they name, NULL where the context is older. */

#define GLBK_FUNCTIONS(X)                                                                                            \
    X(CORE, const uint8_t *, GetString, (uint32_t name))                                                             \
    X(CORE, const uint8_t *, GetStringi, (uint32_t name, uint32_t index))                                            \
    X(CORE, uint32_t, GetError, (void))                                                                              \
    X(CORE, void, GetIntegerv, (uint32_t name, int32_t *out))                                                        \
    X(CORE, void, GetFloatv, (uint32_t name, float *out))                                                            \
    X(CORE, void, GetBooleanv, (uint32_t name, uint8_t *out))                                                        \
    X(CORE, void, GetIntegeri_v, (uint32_t name, uint32_t index, int32_t *out))                                      \
    X(CORE, void, GetInteger64i_v, (uint32_t name, uint32_t index, int64_t *out))                                    \
    X(CORE, uint8_t, IsEnabled, (uint32_t cap))                                                                      \
    X(CORE, void, Enable, (uint32_t cap))                                                                            \
    X(CORE, void, Disable, (uint32_t cap))                                                                           \
    X(CORE, void, Viewport, (int32_t x, int32_t y, int32_t width, int32_t height))                                   \
    X(CORE, void, Scissor, (int32_t x, int32_t y, int32_t width, int32_t height))                                    \
    X(CORE, void, ColorMask, (uint8_t r, uint8_t g, uint8_t b, uint8_t a))                                           \
    X(CORE, void, DepthMask, (uint8_t on))                                                                           \
    X(CORE, void, DepthFunc, (uint32_t func))                                                                        \
    X(CORE, void, CullFace, (uint32_t face))                                                                         \
    X(CORE, void, FrontFace, (uint32_t order))                                                                       \
    X(CORE, void, PolygonOffset, (float factor, float units))                                                        \
    X(CORE, void, BlendEquationSeparate, (uint32_t rgb, uint32_t alpha))                                             \
    X(CORE, void, BlendFuncSeparate, (uint32_t srgb, uint32_t drgb, uint32_t salpha, uint32_t dalpha))               \
    X(CORE, void, ClearBufferfv, (uint32_t buffer, int32_t index, const float *value))                               \
    X(CORE, void, ClearBufferuiv, (uint32_t buffer, int32_t index, const uint32_t *value))                           \
    X(CORE, void, ClearBufferiv, (uint32_t buffer, int32_t index, const int32_t *value))                             \
    X(CORE, void, PixelStorei, (uint32_t name, int32_t value))                                                       \
    X(CORE, void, ReadPixels, (int32_t x, int32_t y, int32_t width, int32_t height, uint32_t format, uint32_t type,  \
                               void *out))                                                                           \
    X(CORE, void, ActiveTexture, (uint32_t unit))                                                                    \
    X(CORE, void, GenTextures, (int32_t count, uint32_t *names))                                                     \
    X(CORE, void, DeleteTextures, (int32_t count, const uint32_t *names))                                            \
    X(CORE, void, BindTexture, (uint32_t target, uint32_t name))                                                     \
    X(CORE, void, BindSampler, (uint32_t unit, uint32_t name))                                                       \
    X(CORE, void, TexParameteri, (uint32_t target, uint32_t name, int32_t value))                                    \
    X(CORE, void, GenerateMipmap, (uint32_t target))                                                                 \
    X(CORE, void, TexImage2D, (uint32_t target, int32_t level, int32_t internal, int32_t width, int32_t height,      \
                               int32_t border, uint32_t format, uint32_t type, const void *data))                    \
    X(CORE, void, TexImage3D, (uint32_t target, int32_t level, int32_t internal, int32_t width, int32_t height,      \
                               int32_t depth, int32_t border, uint32_t format, uint32_t type, const void *data))     \
    X(CORE, void, TexSubImage2D, (uint32_t target, int32_t level, int32_t x, int32_t y, int32_t width,               \
                                  int32_t height, uint32_t format, uint32_t type, const void *data))                 \
    X(CORE, void, TexSubImage3D, (uint32_t target, int32_t level, int32_t x, int32_t y, int32_t z, int32_t width,    \
                                  int32_t height, int32_t depth, uint32_t format, uint32_t type, const void *data))  \
    X(CORE, void, GenFramebuffers, (int32_t count, uint32_t *names))                                                 \
    X(CORE, void, DeleteFramebuffers, (int32_t count, const uint32_t *names))                                        \
    X(CORE, void, BindFramebuffer, (uint32_t target, uint32_t name))                                                 \
    X(CORE, void, FramebufferTexture2D, (uint32_t target, uint32_t attachment, uint32_t textarget, uint32_t texture, \
                                         int32_t level))                                                             \
    X(CORE, void, FramebufferTextureLayer, (uint32_t target, uint32_t attachment, uint32_t texture, int32_t level,   \
                                            int32_t layer))                                                          \
    X(CORE, uint32_t, CheckFramebufferStatus, (uint32_t target))                                                     \
    X(CORE, void, DrawBuffers, (int32_t count, const uint32_t *buffers))                                             \
    X(CORE, void, ReadBuffer, (uint32_t source))                                                                     \
    X(CORE, void, BlitFramebuffer, (int32_t x0, int32_t y0, int32_t x1, int32_t y1, int32_t to_x0, int32_t to_y0,    \
                                    int32_t to_x1, int32_t to_y1, uint32_t mask, uint32_t filter))                   \
    X(CORE, void, GenBuffers, (int32_t count, uint32_t *names))                                                      \
    X(CORE, void, DeleteBuffers, (int32_t count, const uint32_t *names))                                             \
    X(CORE, void, BindBuffer, (uint32_t target, uint32_t name))                                                      \
    X(CORE, void, BindBufferBase, (uint32_t target, uint32_t index, uint32_t name))                                  \
    X(CORE, void, BindBufferRange, (uint32_t target, uint32_t index, uint32_t name, ptrdiff_t offset,                \
                                    ptrdiff_t size))                                                                 \
    X(CORE, void, BufferData, (uint32_t target, ptrdiff_t size, const void *data, uint32_t usage))                   \
    X(CORE, void, BufferSubData, (uint32_t target, ptrdiff_t offset, ptrdiff_t size, const void *data))              \
    X(CORE, void, GenVertexArrays, (int32_t count, uint32_t *names))                                                 \
    X(CORE, void, DeleteVertexArrays, (int32_t count, const uint32_t *names))                                        \
    X(CORE, void, BindVertexArray, (uint32_t name))                                                                  \
    X(CORE, void, EnableVertexAttribArray, (uint32_t index))                                                         \
    X(CORE, void, VertexAttribPointer, (uint32_t index, int32_t size, uint32_t type, uint8_t normalized,             \
                                        int32_t stride, const void *offset))                                         \
    X(CORE, void, VertexAttribIPointer, (uint32_t index, int32_t size, uint32_t type, int32_t stride,                \
                                         const void *offset))                                                        \
    X(CORE, void, VertexAttribDivisor, (uint32_t index, uint32_t divisor))                                           \
    X(CORE, void, DrawArrays, (uint32_t mode, int32_t first, int32_t count))                                         \
    X(CORE, void, DrawElements, (uint32_t mode, int32_t count, uint32_t type, const void *offset))                   \
    X(CORE, void, DrawArraysInstanced, (uint32_t mode, int32_t first, int32_t count, int32_t instances))             \
    X(CORE, void, DrawElementsInstanced, (uint32_t mode, int32_t count, uint32_t type, const void *offset,           \
                                          int32_t instances))                                                        \
    X(CORE, uint32_t, CreateShader, (uint32_t type))                                                                 \
    X(CORE, void, ShaderSource, (uint32_t shader, int32_t count, const char *const *texts, const int32_t *lengths))  \
    X(CORE, void, CompileShader, (uint32_t shader))                                                                  \
    X(CORE, void, GetShaderiv, (uint32_t shader, uint32_t name, int32_t *out))                                       \
    X(CORE, void, GetShaderInfoLog, (uint32_t shader, int32_t size, int32_t *length, char *log))                     \
    X(CORE, void, DeleteShader, (uint32_t shader))                                                                   \
    X(CORE, uint32_t, CreateProgram, (void))                                                                         \
    X(CORE, void, AttachShader, (uint32_t program, uint32_t shader))                                                 \
    X(CORE, void, TransformFeedbackVaryings, (uint32_t program, int32_t count, const char *const *names,             \
                                              uint32_t mode))                                                        \
    X(CORE, void, LinkProgram, (uint32_t program))                                                                   \
    X(CORE, void, GetProgramiv, (uint32_t program, uint32_t name, int32_t *out))                                     \
    X(CORE, void, GetProgramInfoLog, (uint32_t program, int32_t size, int32_t *length, char *log))                   \
    X(CORE, void, DeleteProgram, (uint32_t program))                                                                 \
    X(CORE, uint8_t, IsProgram, (uint32_t program))                                                                  \
    X(CORE, void, UseProgram, (uint32_t program))                                                                    \
    X(CORE, int32_t, GetUniformLocation, (uint32_t program, const char *name))                                       \
    X(CORE, uint32_t, GetUniformBlockIndex, (uint32_t program, const char *name))                                    \
    X(CORE, void, UniformBlockBinding, (uint32_t program, uint32_t index, uint32_t binding))                         \
    X(CORE, void, Uniform1i, (int32_t location, int32_t x))                                                          \
    X(CORE, void, Uniform1f, (int32_t location, float x))                                                            \
    X(CORE, void, Uniform4fv, (int32_t location, int32_t count, const float *values))                                \
    X(CORE, void, UniformMatrix4fv, (int32_t location, int32_t count, uint8_t transpose, const float *values))       \
    X(CORE, void, BeginTransformFeedback, (uint32_t mode))                                                           \
    X(CORE, void, EndTransformFeedback, (void))                                                                      \
    X(CORE, void, GenQueries, (int32_t count, uint32_t *names))                                                      \
    X(CORE, void, DeleteQueries, (int32_t count, const uint32_t *names))                                             \
    X(CORE, void, BeginQuery, (uint32_t target, uint32_t name))                                                      \
    X(CORE, void, EndQuery, (uint32_t target))                                                                       \
    X(CORE, void, GetQueryObjectuiv, (uint32_t name, uint32_t what, uint32_t *out))                                  \
    X(CORE, void, Finish, (void))                                                                                    \
    X(ES, void, DepthRangef, (float from, float to))                                                                 \
    X(DESK, void, DepthRange, (double from, double to))                                                              \
    X(DESK, void, PolygonMode, (uint32_t face, uint32_t mode))                                                       \
    X(DESK, void, PointSize, (float size))                                                                           \
    X(DESK, void, ClampColor, (uint32_t target, uint32_t clamp))                                                     \
    X(DESK, void, ColorMaski, (uint32_t index, uint8_t r, uint8_t g, uint8_t b, uint8_t a))                          \
    X(DESK, void, GetBooleani_v, (uint32_t name, uint32_t index, uint8_t *out))                                      \
    X(DESK, void, Enablei, (uint32_t cap, uint32_t index))                                                           \
    X(DESK, void, Disablei, (uint32_t cap, uint32_t index))                                                          \
    X(DESK, uint8_t, IsEnabledi, (uint32_t cap, uint32_t index))                                                     \
    X(DESK, void, GetBufferSubData, (uint32_t target, ptrdiff_t offset, ptrdiff_t size, void *out))                  \
    X(DESK, void, QueryCounter, (uint32_t name, uint32_t target))                                                    \
    X(DESK, void, GetQueryObjectui64v, (uint32_t name, uint32_t what, uint64_t *out))                                \
    X(COMPUTE, void, DispatchCompute, (uint32_t x, uint32_t y, uint32_t z))                                          \
    X(COMPUTE, void, Barrier, (uint32_t bits)) /* glMemoryBarrier: windows.h has a macro of that name */              \
    X(CLIP, void, ClipControl, (uint32_t origin, uint32_t depth))

typedef struct glbk_functions {
#define GLBK__FIELD(group, type, name, parameters) type(GLBK_CALL *name) parameters;
    GLBK_FUNCTIONS(GLBK__FIELD)
#undef GLBK__FIELD
} glbk_functions;

/* What the sections below and most users need of GL's constants. */
#define GLBK_GL_TRIANGLES 0x0004u
#define GLBK_GL_TRIANGLE_STRIP 0x0005u
#define GLBK_GL_POINTS 0x0000u
#define GLBK_GL_LINES 0x0001u
#define GLBK_GL_BYTE 0x1400u
#define GLBK_GL_UNSIGNED_BYTE 0x1401u
#define GLBK_GL_UNSIGNED_SHORT 0x1403u
#define GLBK_GL_INT 0x1404u
#define GLBK_GL_UNSIGNED_INT 0x1405u
#define GLBK_GL_FLOAT 0x1406u
#define GLBK_GL_HALF_FLOAT 0x140Bu
#define GLBK_GL_COLOR 0x1800u
#define GLBK_GL_DEPTH 0x1801u
#define GLBK_GL_TEXTURE_2D 0x0DE1u
#define GLBK_GL_TEXTURE_2D_ARRAY 0x8C1Au
#define GLBK_GL_TEXTURE0 0x84C0u
#define GLBK_GL_FRAMEBUFFER 0x8D40u
#define GLBK_GL_READ_FRAMEBUFFER 0x8CA8u
#define GLBK_GL_DRAW_FRAMEBUFFER 0x8CA9u
#define GLBK_GL_COLOR_ATTACHMENT0 0x8CE0u
#define GLBK_GL_DEPTH_ATTACHMENT 0x8D00u
#define GLBK_GL_ARRAY_BUFFER 0x8892u
#define GLBK_GL_ELEMENT_ARRAY_BUFFER 0x8893u
#define GLBK_GL_UNIFORM_BUFFER 0x8A11u
#define GLBK_GL_SHADER_STORAGE_BUFFER 0x90D2u
#define GLBK_GL_COPY_WRITE_BUFFER 0x8F37u
#define GLBK_GL_TRANSFORM_FEEDBACK_BUFFER 0x8C8Eu
#define GLBK_GL_INTERLEAVED_ATTRIBS 0x8C8Cu
#define GLBK_GL_RASTERIZER_DISCARD 0x8C89u
#define GLBK_GL_STATIC_DRAW 0x88E4u
#define GLBK_GL_STREAM_DRAW 0x88E0u
#define GLBK_GL_ANY_SAMPLES_PASSED 0x8C2Fu
#define GLBK_GL_QUERY_RESULT 0x8866u
#define GLBK_GL_ALL_BARRIER_BITS 0xFFFFFFFFu

/* ---- the context ---- */

typedef void (*glbk_proc)(void);
typedef glbk_proc (*glbk_get_proc)(const char *name, void *user);
/* Returns GL's function of that full name ("glBindTexture") or NULL. */

typedef struct glbk_allocator {     /* all zero = malloc and free; else both functions */
    void *(*alloc_fn)(size_t size, void *user);   /* 16-byte aligned like malloc, or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} glbk_allocator;

typedef struct glbk_desc {
    glbk_get_proc  get_proc;        /* required */
    void          *user;            /* handed to get_proc */
    char          *log;             /* text of the last error, cut to fit and ended by 0; must outlive the context */
    size_t         log_size;        /* bytes; 0 = no texts */
    int            core_only;       /* not 0: what 3.3 and ES 3.0 share, even where the context has more */
    uint32_t       first_unit;      /* texture units first_unit .. + 15 are ours while we draw */
    uint32_t       first_block;     /* likewise uniform (and storage) buffer bindings, first_block .. + 7 */
    glbk_allocator allocator;
} glbk_desc;                        /* zero it, then set what you care about */

typedef struct glbk_context {
    glbk_functions gl;              /* gl.BindTexture(...): yours to call, too */
    const char    *renderer;        /* the driver's, valid while the context lives */
    int            es;              /* OpenGL ES or WebGL */
    uint32_t       version;         /* 330 .. 460, or 300 .. 320 with es */
    int            compute;         /* OpenGL 4.3: compute shaders and storage buffers */
    int            float_targets;   /* RGBA32F and the like are renderable */
    int            float_blend;     /* ... and can be blended into */
    int            float_linear;    /* 32-bit float textures can be filtered */
    int            clip_control;
    uint32_t       max_size;        /* texels a side of a 2D texture */
    uint32_t       max_layers;      /* of an array texture */
    uint32_t       max_targets;     /* colour attachments that can be drawn to at once */
    float          max_point_size;
    /* The rest is private. */
    uint32_t       vertex_array;    /* empty, for passes that need no attributes */
    int            lost;            /* calls no GL any more */
    char          *log;
    size_t         log_size;
    uint32_t       first_unit, first_block;
    glbk_allocator allocator;
} glbk_context;

#define GLBK_UNITS 16u              /* slots of textures, of uniform blocks, of storage buffers */
#define GLBK_BLOCKS 8u

GLBK_DEF glbk_result glbk_init(glbk_context *ctx, const glbk_desc *desc);
/* Loads the functions, decides what the current context can do, makes one empty vertex array.
   ctx      yours; may be moved in memory; zeroed on errors
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_CONTEXT; GLBK_ERR_VERSION; GLBK_ERR_FUNCTION, its name in the log;
            GLBK_ERR_LIMIT where first_unit or first_block reach beyond what the context has; GLBK_ERR_PENDING,
            GLBK_ERR_LOST, GLBK_ERR_GL, GLBK_ERR_GL_MEMORY */

GLBK_DEF void glbk_destroy(glbk_context *ctx);
/* Deletes what glbk_init made and zeroes ctx. Destroy textures and the like before. NULL is allowed. */

GLBK_DEF void glbk_abandon(glbk_context *ctx);
/* The GL context is gone or not current: from now on destroying calls touch memory only, all others return
   GLBK_ERR_LOST. */

GLBK_DEF glbk_result glbk_check(glbk_context *ctx);
/* GL's error flag as a result, with its number in the log; for tests and after passes, which do not ask for it. */

/* ---- textures ---- */

/* X(name, internal format, format, type, bytes a texel, components): formats that both dialects know. */
#define GLBK_FORMATS(X)                                             \
    X(GLBK_FORMAT_NONE, 0, 0, 0, 0, 0)                              \
    X(GLBK_FORMAT_COLOR, 0, 0, 0, 0, 4) /* RGBA32F, or its bits */  \
    X(GLBK_FORMAT_R8, 0x8229, 0x1903, 0x1401, 1, 1)                 \
    X(GLBK_FORMAT_RGBA8, 0x8058, 0x1908, 0x1401, 4, 4)              \
    X(GLBK_FORMAT_SRGB8_A8, 0x8C43, 0x1908, 0x1401, 4, 4)           \
    X(GLBK_FORMAT_R8UI, 0x8232, 0x8D94, 0x1401, 1, 1)               \
    X(GLBK_FORMAT_RGBA8UI, 0x8D7C, 0x8D99, 0x1401, 4, 4)            \
    X(GLBK_FORMAT_R16UI, 0x8234, 0x8D94, 0x1403, 2, 1)              \
    X(GLBK_FORMAT_RG16UI, 0x823A, 0x8228, 0x1403, 4, 2)             \
    X(GLBK_FORMAT_RGBA16UI, 0x8D76, 0x8D99, 0x1403, 8, 4)           \
    X(GLBK_FORMAT_R32UI, 0x8236, 0x8D94, 0x1405, 4, 1)              \
    X(GLBK_FORMAT_RG32UI, 0x823C, 0x8228, 0x1405, 8, 2)             \
    X(GLBK_FORMAT_RGBA32UI, 0x8D70, 0x8D99, 0x1405, 16, 4)          \
    X(GLBK_FORMAT_R16F, 0x822D, 0x1903, 0x140B, 2, 1)               \
    X(GLBK_FORMAT_RGBA16F, 0x881A, 0x1908, 0x140B, 8, 4)            \
    X(GLBK_FORMAT_R32F, 0x822E, 0x1903, 0x1406, 4, 1)               \
    X(GLBK_FORMAT_RG32F, 0x8230, 0x8227, 0x1406, 8, 2)              \
    X(GLBK_FORMAT_RGBA32F, 0x8814, 0x1908, 0x1406, 16, 4)           \
    X(GLBK_FORMAT_DEPTH24, 0x81A6, 0x1902, 0x1405, 4, 1)            \
    X(GLBK_FORMAT_DEPTH32F, 0x8CAC, 0x1902, 0x1406, 4, 1)

typedef enum glbk_format {
#define GLBK__ENUM(name, internal, format, type, bytes, components) name,
    GLBK_FORMATS(GLBK__ENUM)
#undef GLBK__ENUM
    GLBK_FORMAT_COUNT
} glbk_format;

typedef enum glbk_sampling {
    GLBK_SAMPLING_DEFAULT,          /* = GLBK_SAMPLING_NEAREST */
    GLBK_SAMPLING_NEAREST,
    GLBK_SAMPLING_LINEAR,           /* not for integers; 32-bit floats need ctx->float_linear */
    GLBK_SAMPLING_MIPMAPS,          /* linear, and between levels; they are generated on creation from data */
    GLBK_SAMPLING_COMPARE,          /* depth formats: linear comparison, sampler2DShadow */
    GLBK_SAMPLING_COUNT
} glbk_sampling;

typedef struct glbk_texture_desc {
    glbk_format   format;           /* required; GLBK_FORMAT_COLOR = GLBK_FORMAT_RGBA32F or RGBA32UI, see above */
    uint32_t      width, height;    /* 1 .. ctx->max_size */
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
/* Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_LIMIT, GLBK_ERR_GL_MEMORY, GLBK_ERR_PENDING, GLBK_ERR_GL, GLBK_ERR_LOST: the
            last four hold for every function below that returns a result and calls GL */

GLBK_DEF glbk_result glbk_texture_update(glbk_context *ctx, const glbk_texture *texture, uint32_t level, uint32_t x,
                                         uint32_t y, uint32_t layer, uint32_t width, uint32_t height,
                                         uint32_t layers, const void *data);
/* A box of texels, rows and layers without padding; layer 0 and layers 1 for a 2D texture. */

GLBK_DEF glbk_result glbk_table_create(glbk_context *ctx, glbk_format format, const void *texels, size_t count,
                                       glbk_texture *out);
/* An array texture that lib/table.glsl reads by one number: texel i stands at (i & 1023, i >> 10 & 1023, i >> 20).
   texels   count of them, 1 .. ctx->max_layers * 2^20, or NULL = undefined; any format but the depth formats
   Memory on the GPU: count rounded up to rows of 1024, above 2^20 texels to layers of 2^20.
   Errors   GLBK_ERR_LIMIT */

GLBK_DEF glbk_result glbk_table_update(glbk_context *ctx, const glbk_texture *table, size_t first, size_t count,
                                       const void *texels);

GLBK_DEF void glbk_texture_destroy(glbk_context *ctx, glbk_texture *texture);

/* ---- buffers: uniform blocks, vertices, and storage where ctx->compute ---- */

typedef struct glbk_buffer {        /* read only; zeroed = none */
    uint32_t name;
    size_t   size;
} glbk_buffer;

GLBK_DEF glbk_result glbk_buffer_create(glbk_context *ctx, size_t size, const void *data, glbk_buffer *out);
/* size > 0 bytes; data NULL = undefined. A buffer may serve for any purpose, but for WebGL's sake not for indices and
   something else in turn. */
GLBK_DEF glbk_result glbk_buffer_update(glbk_context *ctx, const glbk_buffer *buffer, size_t offset, size_t size,
                                        const void *data);
GLBK_DEF glbk_result glbk_buffer_read(glbk_context *ctx, const glbk_buffer *buffer, size_t offset, size_t size,
                                      void *out);
/* Waits for the GPU. Not on ES and WebGL: GLBK_ERR_FEATURE. */
GLBK_DEF void glbk_buffer_destroy(glbk_context *ctx, glbk_buffer *buffer);

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
} glbk_target;

GLBK_DEF glbk_result glbk_target_create(glbk_context *ctx, const glbk_target_desc *desc, glbk_target *out);
/* Errors   GLBK_ERR_ARGUMENT (no attachment, sizes differ), GLBK_ERR_FLOAT_TARGET, GLBK_ERR_TARGET */

GLBK_DEF glbk_result glbk_target_read(glbk_context *ctx, const glbk_target *target, uint32_t attachment, uint32_t x,
                                      uint32_t y, uint32_t width, uint32_t height, void *rgba);
/* Pixels from the GPU, which is waited for: four 32-bit words each, floats, or integers where the format has integers
   (of a GLBK_FORMAT_COLOR target these are the floats in either case); rows from the bottom up. */

GLBK_DEF void glbk_target_destroy(glbk_context *ctx, glbk_target *target);

/* ---- GLSL and programs ---- */

typedef struct glbk_file {          /* one file of src/shaders as it is embedded */
    const char        *name;        /* "lib/table.glsl", "prog/copy.frag" */
    const char *const *lines;       /* each ended by \n: fit for glShaderSource */
    uint32_t           line_count;
    const char        *uses;        /* library files that go before it, by their bare names: "table noise" */
    const char        *with;        /* of a .frag: its vertex shader; else "" */
    const char        *sets;        /* the define sets that are tested, separated by " | " */
} glbk_file;

GLBK_DEF const glbk_file *glbk_files(uint32_t *count);
/* All embedded GLSL, for those who bring their own upload and passes. Needs no context. */
GLBK_DEF const glbk_file *glbk_find_file(const char *name);
/* NULL where there is none. */

typedef struct glbk_source {        /* a program: of the library, or your own with parts of it */
    const char *vertex;             /* main of the vertex shader as text; NULL = a triangle over the whole screen */
    const char *fragment;           /* main of the fragment shader as text, or NULL with compute */
    const char *compute;
    const char *uses;               /* library files by their bare names, in order, without what they use themselves */
    const char *defines;            /* "FILTER=1 FAST", or NULL; the vertex shader sees them too */
    const char *outputs;            /* names for transform feedback, separated by blanks, interleaved; or NULL */
} glbk_source;

typedef struct glbk_program {       /* read only; zeroed = none */
    uint32_t name;
    int      slots_set;             /* private */
} glbk_program;

GLBK_DEF glbk_result glbk_program_create(glbk_context *ctx, const char *name, const char *defines,
                                         glbk_program *out);
/* A program of the library.
   name     of its last stage: "copy.frag", "csm_query.comp"
   defines  one of its sets, or NULL = none
   Errors   GLBK_ERR_NAME; GLBK_ERR_COMPILE, GLBK_ERR_LINK, the driver's words in the log, where line 2007 is line 7 of
            file 2, listed there too; GLBK_ERR_ALLOC; GLBK_ERR_FEATURE: .comp without ctx->compute */

GLBK_DEF glbk_result glbk_program_compile(glbk_context *ctx, const glbk_source *source, glbk_program *out);
/* Likewise from your text, which has no #version line: glbk writes it, and lib/prelude.glsl after it. */

typedef enum glbk_dialect { GLBK_GLSL_330, GLBK_GLSL_300_ES, GLBK_GLSL_430, GLBK_DIALECT_COUNT } glbk_dialect;

GLBK_DEF size_t glbk_write_glsl(glbk_dialect dialect, int float_bits, const char *uses, const char *defines,
                                const char *main_name, const char *main_text, char *out, size_t size);
/* The text that the two above give to the driver, for your own renderer. Needs no context.
   float_bits   GLBK_FORMAT_COLOR targets hold integers
   main_name    an embedded file (its own uses come after those given), or NULL; main_text your text, or NULL
   out          receives it, cut to size and ended by 0; may be NULL with size 0
   Returns the bytes needed with the 0, or 0 where a name is unknown or defines do not parse. */

GLBK_DEF void glbk_program_destroy(glbk_context *ctx, glbk_program *program);

GLBK_DEF void glbk_program_use(glbk_context *ctx, glbk_program *program);
/* glUseProgram, and at the first time its textures and blocks get their slots. */

GLBK_DEF void glbk_set_slots(glbk_context *ctx, uint32_t gl_program);
/* The same for a program that you linked yourself and that is in use: every texture and block of our lists that it
   declares gets its slot. */

/* ---- passes ---- */

typedef enum glbk_depth {
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

typedef struct glbk_pass {
    const glbk_target *target;      /* NULL = the framebuffer that is bound; then the viewport must be given */
    int32_t            viewport[4]; /* x, y, width, height; all zero = the whole target */
    glbk_depth         depth;
    glbk_blend         blend;
    glbk_cull          cull;
    int                no_color;    /* not 0: writes depth only */
    float              offset[2];   /* of depth: factor and units of glPolygonOffset; both 0 = off */
} glbk_pass;                        /* all zero but the target: overwrite everything */

GLBK_DEF glbk_result glbk_begin(glbk_context *ctx, const glbk_pass *pass, glbk_program *program);
/* Sets every state that a draw depends on, so that nothing inherited shows; binds target and program and the empty
   vertex array. Bind textures and blocks after it. docs/gl-state.md lists what is touched.
   program  NULL where you use your own
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_LOST; GL's error flag is not asked */

GLBK_DEF void glbk_clear(glbk_context *ctx, const glbk_target *target, uint32_t attachment, const float rgba[4]);
/* After glbk_begin to that target. Integer formats get the numbers, rounded; GLBK_FORMAT_COLOR the floats. */
GLBK_DEF void glbk_clear_depth(glbk_context *ctx, float depth);
/* After glbk_begin with a depth mode that writes. */

GLBK_DEF void glbk_bind_texture(glbk_context *ctx, uint32_t slot, const glbk_texture *texture);
/* To a slot of the lists (GLBK_SLOT_name), without a sampler object. */
GLBK_DEF void glbk_bind_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer);
/* The whole buffer as uniform block. */
GLBK_DEF void glbk_bind_storage(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer);
/* The whole buffer as storage buffer; with ctx->compute only. */

GLBK_DEF void glbk_draw_screen(glbk_context *ctx);
/* One triangle over the whole viewport: after glbk_begin. */

GLBK_DEF glbk_result glbk_dispatch(glbk_context *ctx, glbk_program *program, uint32_t x, uint32_t y, uint32_t z);
/* Runs x * y * z groups of a compute program and makes what it wrote visible to everything after it.
   Errors   GLBK_ERR_FEATURE, GLBK_ERR_LOST */

/* ---- state ---- */

typedef struct glbk_state {         /* private: what glbk_begin and the binding calls may change */
    uint8_t  caps[32], blend[8];
    uint8_t  color_mask[8][4], depth_mask;
    int32_t  words[20];
    int32_t  viewport[4];
    float    floats[4];
    int32_t  units[GLBK_UNITS][3];
    int32_t  blocks[GLBK_BLOCKS], storage[GLBK_BLOCKS];
    int64_t  ranges[GLBK_BLOCKS][2], storage_ranges[GLBK_BLOCKS][2];
} glbk_state;

GLBK_DEF void glbk_state_save(glbk_context *ctx, glbk_state *out);
GLBK_DEF void glbk_state_restore(glbk_context *ctx, const glbk_state *state);
/* Round a pass or a whole frame of them, where the rest of your renderer relies on its state. What was bound must not be
   deleted in between; a program that you had deleted while it was in use is gone (0) afterwards, as GL says. */

/* ---- bindings ----

   Each part (technique) has three lists, empty where it needs none, and is itself named in GLBK_PARTS:

     GLBK_part_TEXTURES(X)   X(GLSL type, name, slot)
     GLBK_part_BLOCKS(X)     X(name, slot, MEMBERS), each with a list MEMBERS(X): X(GLSL type, name, count)
     GLBK_part_STORAGE(X)    X(qualifiers, GLSL type, name, slot), an array without size, for compute

   Slots of textures count from 0 to GLBK_UNITS - 1, those of blocks and storage to GLBK_BLOCKS - 1, anew in each part:
   one program uses one part and base. From the lists come GLBK_SLOT_name, the C struct of each block (std140: only mat4, vec4, ivec4, uvec4 and arrays of them,
   so that both layouts are the same), and the library file "part_bindings". Members are read as block.member. */

#define GLBK_PARTS(X) X(base, BASE)

#define GLBK_BASE_TEXTURES(X) X(glbk_color_sampler, glbk_source, 0)
#define GLBK_BASE_BLOCKS(X)
#define GLBK_BASE_STORAGE(X)

#define GLBK__SLOT_TEXTURE(type, name, slot) GLBK_SLOT_##name = slot,
#define GLBK__SLOT_BLOCK(name, slot, members) GLBK_SLOT_##name = slot,
#define GLBK__SLOT_STORAGE(qualifiers, type, name, slot) GLBK_SLOT_##name = slot,
#define GLBK__MEMBER_mat4(name, count) float name[16 * (count)];
#define GLBK__MEMBER_vec4(name, count) float name[4 * (count)];
#define GLBK__MEMBER_ivec4(name, count) int32_t name[4 * (count)];
#define GLBK__MEMBER_uvec4(name, count) uint32_t name[4 * (count)];
#define GLBK__MEMBER(type, name, count) GLBK__MEMBER_##type(name, count)
#define GLBK__STRUCT(name, slot, members) typedef struct name { members(GLBK__MEMBER) } name;
#define GLBK__PART(PART)                        \
    enum {                                      \
        GLBK_##PART##_TEXTURES(GLBK__SLOT_TEXTURE)  \
        GLBK_##PART##_BLOCKS(GLBK__SLOT_BLOCK)      \
        GLBK_##PART##_STORAGE(GLBK__SLOT_STORAGE)   \
        GLBK__LAST_SLOT_##PART                  \
    };                                          \
    GLBK_##PART##_BLOCKS(GLBK__STRUCT)
GLBK__PART(BASE)

/* ---- techniques: one section each; src/README.md says how ---- */

/* ---- end of the techniques ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_BACKEND_H */

/* ==== implementation ============================================================================================== */

#if defined(GL_BACKEND_IMPLEMENTATION) && !defined(GL_BACKEND_IMPLEMENTED)
#define GL_BACKEND_IMPLEMENTED

#include <stdlib.h>
#include <string.h>

#ifndef GLBK_ASSERT
#include <assert.h>
#define GLBK_ASSERT(condition) assert(condition)
#endif

/* >>> shared mem: written by tools/stamp from src/shared, edit there */

/* unit mem: checked sizes, and the caller's allocator with malloc and free as its default */

typedef struct glbk__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} glbk__allocator;

static inline void *glbk__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void glbk__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* *out = a * b and 1, or 0 and *out untouched where the product does not fit. */
static inline int glbk__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

static inline int glbk__add_size(size_t a, size_t b, size_t *out)
{
    if (a > SIZE_MAX - b) return 0;
    *out = a + b;
    return 1;
}

/* Takes the members of a public desc. Both functions or none: valid() is what the desc check asks. */
static inline int glbk__allocator_valid(void *(*alloc_fn)(size_t, void *), void (*free_fn)(void *, void *))
{
    return (alloc_fn == NULL) == (free_fn == NULL);
}

static inline glbk__allocator glbk__allocator_make(void *(*alloc_fn)(size_t, void *), void (*free_fn)(void *, void *),
                                           void *user)
{
    glbk__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : glbk__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : glbk__default_free;
    a.user = user;
    return a;
}

/* NULL where the size is 0 or overflows, so that a caller has one thing to test. */
static inline void *glbk__alloc(const glbk__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *glbk__alloc_array(const glbk__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return glbk__mul_size(count, item_size, &size) ? glbk__alloc(a, size) : NULL;
}

static inline void glbk__free(const glbk__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* <<< shared */

/* >>> glsl: written by tools/embed from src/shaders and GLBK_PARTS, edit there */

static const char *const glbk__glsl_lib_base_bindings_glsl[] = {
    "// base_bindings - from the lists GLBK_BASE_* of gl_backend.h.\n",
    "uniform glbk_color_sampler glbk_source;\n"
};

static const char *const glbk__glsl_lib_prelude_glsl[] = {
    "// prelude - goes before everything else: precision, and targets that hold the bits of floats.\n",
    "#ifdef GL_ES\n",
    "precision highp float;\n",
    "precision highp int;\n",
    "precision highp sampler2D;\n",
    "precision highp sampler3D;\n",
    "precision highp samplerCube;\n",
    "precision highp sampler2DArray;\n",
    "precision highp sampler2DShadow;\n",
    "precision highp sampler2DArrayShadow;\n",
    "precision highp isampler2D;\n",
    "precision highp isampler2DArray;\n",
    "precision highp usampler2D;\n",
    "precision highp usampler2DArray;\n",
    "#endif\n",
    "\n",
    "#ifndef GLBK_FLOAT_BITS\n",
    "#error \"GLBK_FLOAT_BITS: 1 where GLBK_FORMAT_COLOR is RGBA32UI, else 0\"\n",
    "#endif\n",
    "\n",
    "// An output of such a target is \"layout(location = 0) out glbk_color name;\" and gets glbk_pack(vec4); a texture of that\n",
    "// format is a glbk_color_sampler, glbk_unpack(texelFetch(...)).\n",
    "#if GLBK_FLOAT_BITS\n",
    "#define glbk_color uvec4\n",
    "#define glbk_color_sampler usampler2D\n",
    "uvec4 glbk_pack(vec4 color) { return floatBitsToUint(color); }\n",
    "vec4 glbk_unpack(uvec4 bits) { return uintBitsToFloat(bits); }\n",
    "#else\n",
    "#define glbk_color vec4\n",
    "#define glbk_color_sampler sampler2D\n",
    "vec4 glbk_pack(vec4 color) { return color; }\n",
    "vec4 glbk_unpack(vec4 color) { return color; }\n",
    "#endif\n"
};

static const char *const glbk__glsl_lib_table_glsl[] = {
    "// table - where texel i of a table stands: 1024 wide, 1024 high, then layers (glbk_table_create).\n",
    "ivec3 glbk_table_at(uint i)\n",
    "{\n",
    "    return ivec3(uvec3(i & 1023u, i >> 10 & 1023u, i >> 20));\n",
    "}\n"
};

static const char *const glbk__glsl_prog_copy_frag[] = {
    "// Copies a GLBK_FORMAT_COLOR texture, texel by texel, to a target of the same kind or, with TO_COLOR, to colours.\n",
    "// uses: base_bindings\n",
    "// with: screen.vert\n",
    "// sets: TO_COLOR=0 | TO_COLOR=1\n",
    "#ifndef TO_COLOR\n",
    "#define TO_COLOR 0\n",
    "#endif\n",
    "#if TO_COLOR\n",
    "layout(location = 0) out vec4 result;\n",
    "#else\n",
    "layout(location = 0) out glbk_color result;\n",
    "#endif\n",
    "\n",
    "void main()\n",
    "{\n",
    "    vec4 color = glbk_unpack(texelFetch(glbk_source, ivec2(gl_FragCoord.xy), 0));\n",
    "#if TO_COLOR\n",
    "    result = color;\n",
    "#else\n",
    "    result = glbk_pack(color);\n",
    "#endif\n",
    "}\n"
};

static const char *const glbk__glsl_prog_screen_vert[] = {
    "// A triangle over the whole viewport, from no attributes at all: vertices (-1, -1), (3, -1), (-1, 3).\n",
    "void main()\n",
    "{\n",
    "    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);\n",
    "}\n"
};

static const glbk_file glbk__files[] = {
    { "lib/base_bindings.glsl", glbk__glsl_lib_base_bindings_glsl, 2, "", "",
      "" },
    { "lib/prelude.glsl", glbk__glsl_lib_prelude_glsl, 33, "", "",
      "" },
    { "lib/table.glsl", glbk__glsl_lib_table_glsl, 5, "", "",
      "" },
    { "prog/copy.frag", glbk__glsl_prog_copy_frag, 22, "base_bindings", "screen.vert",
      "TO_COLOR=0 | TO_COLOR=1" },
    { "prog/screen.vert", glbk__glsl_prog_screen_vert, 5, "", "",
      "" }
};

/* <<< glsl */

/* ---- >>log: texts into the caller's buffer ---- */

GLBK_DEF const char *glbk_result_text(glbk_result result)
{
#define GLBK__TEXT(name, text) text,
    static const char *const texts[] = { GLBK_RESULTS(GLBK__TEXT) };
#undef GLBK__TEXT
    return (unsigned)result < (unsigned)GLBK_RESULT_COUNT ? texts[result] : "unknown result";
}

static void glbk__log(glbk_context *ctx, const char *text)
{
    size_t used, room;
    if (!ctx->log || !ctx->log_size) return;
    used = strlen(ctx->log);
    room = ctx->log_size - 1 - used;
    if (strlen(text) < room) room = strlen(text);
    memcpy(ctx->log + used, text, room);
    ctx->log[used + room] = 0;
}

static void glbk__log_clear(glbk_context *ctx)
{
    if (ctx->log && ctx->log_size) ctx->log[0] = 0;
}

/* Hexadecimal, four digits, as GL's constants are known; or decimal. */
static void glbk__log_number(glbk_context *ctx, uint32_t value, uint32_t base)
{
    char text[16];
    int at = 15, least = base == 16 ? 4 : 1;
    text[15] = 0;
    while (value || 15 - at < least) {
        text[--at] = "0123456789abcdef"[value % base];
        value /= base;
    }
    if (base == 16) glbk__log(ctx, "0x");
    glbk__log(ctx, text + at);
}

static glbk_result glbk__fail(glbk_context *ctx, glbk_result result, const char *text, const char *name)
{
    glbk__log(ctx, text);
    glbk__log(ctx, name);
    return result;
}

/* ---- >>errors: GL's error flag ---- */

enum { GLBK__OUT_OF_MEMORY = 0x0505, GLBK__CONTEXT_LOST = 0x0507 };

/* Takes all errors that GL keeps; there may be one for each part of a distributed driver. The count is bounded since a
   driver without a context may return an error for ever. */
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
    glbk__log(ctx, "GL error ");
    glbk__log_number(ctx, first, 16);
    return otherwise == GLBK_ERR_GL && first == GLBK__OUT_OF_MEMORY ? GLBK_ERR_GL_MEMORY : otherwise;
}

/* Every function that can fail and calls GL begins and ends with these. */
static glbk_result glbk__enter(glbk_context *ctx)
{
    if (!ctx) return GLBK_ERR_ARGUMENT;
    glbk__log_clear(ctx);
    return ctx->lost ? GLBK_ERR_LOST : glbk__take_errors(ctx, GLBK_ERR_PENDING);
}

static glbk_result glbk__leave(glbk_context *ctx) { return glbk__take_errors(ctx, GLBK_ERR_GL); }

GLBK_DEF glbk_result glbk_check(glbk_context *ctx)
{
    if (!ctx) return GLBK_ERR_ARGUMENT;
    glbk__log_clear(ctx);
    return ctx->lost ? GLBK_ERR_LOST : glbk__leave(ctx);
}

/* ---- >>init: functions and what the context can do ---- */

enum { GLBK__GROUP_CORE, GLBK__GROUP_ES, GLBK__GROUP_DESK, GLBK__GROUP_COMPUTE, GLBK__GROUP_CLIP };

typedef struct glbk__function {
    const char *name;
    size_t      offset;
    int         group;
} glbk__function;

static const glbk__function glbk__functions[] = {
#define GLBK__ENTRY(group, type, name, parameters) { "gl" #name, offsetof(glbk_functions, name), GLBK__GROUP_##group },
    GLBK_FUNCTIONS(GLBK__ENTRY)
#undef GLBK__ENTRY
};

/* Loads one group. Returns the name of a function that is missing, or NULL. */
static const char *glbk__load(glbk_context *ctx, const glbk_desc *desc, int group)
{
    size_t i;
    for (i = 0; i < sizeof glbk__functions / sizeof glbk__functions[0]; i++) {
        const glbk__function *f = &glbk__functions[i];
        const char *name = strcmp(f->name, "glBarrier") == 0 ? "glMemoryBarrier" : f->name;
        glbk_proc proc;
        if (f->group != group) continue;
        proc = desc->get_proc(name, desc->user);
        if (!proc) return name;
        memcpy((char *)&ctx->gl + f->offset, &proc, sizeof proc);
    }
    return NULL;
}

/* "4.5 (Core Profile) ...", "OpenGL ES 3.0 ...", "OpenGL ES 3.0 (WebGL 2.0 ...)": the first number is the version. */
static void glbk__read_version(glbk_context *ctx, const char *text)
{
    const char *s = text;
    uint32_t major = 0;
    ctx->es = strstr(text, "OpenGL ES") != NULL;
    ctx->version = 0;
    while (*s && (*s < '0' || *s > '9')) s++;
    while (*s >= '0' && *s <= '9' && major < 100) major = 10 * major + (uint32_t)(*s++ - '0');
    if (s[0] == '.' && s[1] >= '0' && s[1] <= '9') ctx->version = 100 * major + 10 * (uint32_t)(s[1] - '0');
}

static int glbk__has_extension(const glbk_context *ctx, const char *name)
{
    int32_t count = 0, i;
    ctx->gl.GetIntegerv(0x821D /* NUM_EXTENSIONS */, &count);
    for (i = 0; i < count; i++) {
        const char *text = (const char *)ctx->gl.GetStringi(0x1F03 /* EXTENSIONS */, (uint32_t)i);
        if (text && strcmp(text, name) == 0) return 1;
    }
    return 0;
}

static uint32_t glbk__get(const glbk_context *ctx, uint32_t name)
{
    int32_t value[4] = { 0, 0, 0, 0 };
    ctx->gl.GetIntegerv(name, value);
    return (uint32_t)value[0];
}

static void glbk__read_features(glbk_context *ctx, const glbk_desc *desc)
{
    float points[2] = { 1, 1 };
    int es32 = ctx->es && ctx->version >= 320, desk = !ctx->es;

    ctx->float_targets = desk || es32 || glbk__has_extension(ctx, "GL_EXT_color_buffer_float");
    ctx->float_blend = desk || es32 || (ctx->float_targets && glbk__has_extension(ctx, "GL_EXT_float_blend"));
    ctx->float_linear = desk || glbk__has_extension(ctx, "GL_OES_texture_float_linear");
    ctx->compute = desk && ctx->version >= 430 && !desc->core_only && !glbk__load(ctx, desc, GLBK__GROUP_COMPUTE);
    ctx->clip_control = desk && (ctx->version >= 450 || glbk__has_extension(ctx, "GL_ARB_clip_control")) &&
                        !glbk__load(ctx, desc, GLBK__GROUP_CLIP);
    ctx->max_size = glbk__get(ctx, 0x0D33);
    ctx->max_layers = glbk__get(ctx, 0x88FF);
    ctx->max_targets = glbk__get(ctx, 0x8824 /* MAX_DRAW_BUFFERS */);
    if (ctx->max_targets > 8) ctx->max_targets = 8;
    ctx->gl.GetFloatv(0x846D /* ALIASED_POINT_SIZE_RANGE */, points);
    ctx->max_point_size = points[1];
}

static glbk_result glbk__init(glbk_context *ctx, const glbk_desc *desc)
{
    const char *missing, *version;
    glbk_result result;

    missing = glbk__load(ctx, desc, GLBK__GROUP_CORE);
    if (missing) return glbk__fail(ctx, GLBK_ERR_FUNCTION, "missing: ", missing);
    version = (const char *)ctx->gl.GetString(0x1F02);
    if (!version) return GLBK_ERR_CONTEXT;
    result = glbk__take_errors(ctx, GLBK_ERR_PENDING);
    if (result != GLBK_OK) return result;
    glbk__read_version(ctx, version);
    if (ctx->version < (ctx->es ? 300u : 330u)) return glbk__fail(ctx, GLBK_ERR_VERSION, "this is ", version);
    missing = glbk__load(ctx, desc, ctx->es ? GLBK__GROUP_ES : GLBK__GROUP_DESK);
    if (missing) return glbk__fail(ctx, GLBK_ERR_FUNCTION, "missing: ", missing);
    ctx->renderer = (const char *)ctx->gl.GetString(0x1F01);
    if (!ctx->renderer) ctx->renderer = "";
    glbk__read_features(ctx, desc);
    if (desc->first_unit > 1000 || desc->first_unit + GLBK_UNITS > glbk__get(ctx, 0x8B4D) ||
        desc->first_block > 1000 || desc->first_block + GLBK_BLOCKS > glbk__get(ctx, 0x8A2F))
        return GLBK_ERR_LIMIT;
    ctx->gl.GenVertexArrays(1, &ctx->vertex_array);
    return glbk__leave(ctx);
}

GLBK_DEF glbk_result glbk_init(glbk_context *ctx, const glbk_desc *desc)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    memset(ctx, 0, sizeof *ctx);
    if (!desc || !desc->get_proc || (desc->log_size && !desc->log) ||
        !glbk__allocator_valid(desc->allocator.alloc_fn, desc->allocator.free_fn))
        return GLBK_ERR_ARGUMENT;
    ctx->log = desc->log;
    ctx->log_size = desc->log_size;
    ctx->first_unit = desc->first_unit;
    ctx->first_block = desc->first_block;
    ctx->allocator = desc->allocator;
    glbk__log_clear(ctx);
    result = glbk__init(ctx, desc);
    if (result != GLBK_OK) glbk_destroy(ctx);
    return result;
}

GLBK_DEF void glbk_destroy(glbk_context *ctx)
{
    if (!ctx) return;
    if (ctx->vertex_array && !ctx->lost) ctx->gl.DeleteVertexArrays(1, &ctx->vertex_array);
    memset(ctx, 0, sizeof *ctx);
    ctx->lost = 1;
}

GLBK_DEF void glbk_abandon(glbk_context *ctx)
{
    if (ctx) ctx->lost = 1;
}

/* ---- >>textures ---- */

typedef struct glbk__format_info {
    int32_t  internal;
    uint32_t format, type, bytes, components;
} glbk__format_info;

static const glbk__format_info glbk__formats[] = {
#define GLBK__ENTRY(name, internal, format, type, bytes, components) { internal, format, type, bytes, components },
    GLBK_FORMATS(GLBK__ENTRY)
#undef GLBK__ENTRY
};

static int glbk__is_depth(glbk_format f) { return f == GLBK_FORMAT_DEPTH24 || f == GLBK_FORMAT_DEPTH32F; }

static int glbk__is_integer(glbk_format f)
{
    uint32_t format = glbk__formats[f].format;     /* RED_INTEGER, RG_INTEGER, RGBA_INTEGER */
    return format == 0x8D94 || format == 0x8228 || format == 0x8D99;
}

static int glbk__is_float(glbk_format f)
{
    return !glbk__is_depth(f) && (glbk__formats[f].type == GLBK_GL_FLOAT || glbk__formats[f].type == GLBK_GL_HALF_FLOAT);
}

/* Row lengths, offsets, byte order and pixel buffers that a user left behind would change what GL reads or writes. */
enum { GLBK__UNPACK, GLBK__PACK, GLBK__STORE_COUNT = 8 };

typedef struct glbk__store {
    int32_t value[GLBK__STORE_COUNT], buffer;
} glbk__store;

static const uint32_t glbk__store_names[2][GLBK__STORE_COUNT] = {
    /* alignment, row length, skip rows, skip pixels; then image height, skip images; then swap bytes, LSB first */
    { 0x0CF5, 0x0CF2, 0x0CF3, 0x0CF4, 0x806E, 0x806D, 0x0CF0, 0x0CF1 },
    { 0x0D05, 0x0D02, 0x0D03, 0x0D04, 0x806C, 0x806B, 0x0D00, 0x0D01 }
};
static const uint32_t glbk__store_buffer[2][2] = { { 0x88EC, 0x88EF }, { 0x88EB, 0x88ED } };

/* ES knows the first six for unpacking and the first four for packing. */
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
    for (i = 0; i < glbk__store_count(ctx, way); i++) ctx->gl.PixelStorei(glbk__store_names[way][i], old->value[i]);
    ctx->gl.BindBuffer(glbk__store_buffer[way][0], (uint32_t)old->buffer);
}

static uint32_t glbk__binding_of(uint32_t gl_target) { return gl_target == GLBK_GL_TEXTURE_2D ? 0x8069u : 0x8C1Du; }

static uint32_t glbk__all_levels(uint32_t width, uint32_t height)
{
    uint32_t size = width > height ? width : height, levels = 1;
    while (size > 1) size /= 2, levels++;
    return levels;
}

/* Checks a desc and resolves its defaults in place. */
static glbk_result glbk__check_texture(const glbk_context *ctx, glbk_texture_desc *d)
{
    uint32_t most;
    if (d->format <= GLBK_FORMAT_NONE || d->format >= GLBK_FORMAT_COUNT || (unsigned)d->sampling >= GLBK_SAMPLING_COUNT)
        return GLBK_ERR_ARGUMENT;
    if (d->format == GLBK_FORMAT_COLOR) d->format = ctx->float_targets ? GLBK_FORMAT_RGBA32F : GLBK_FORMAT_RGBA32UI;
    if (!d->width || !d->height) return GLBK_ERR_ARGUMENT;
    if (d->width > ctx->max_size || d->height > ctx->max_size || d->layers > ctx->max_layers) return GLBK_ERR_LIMIT;
    most = glbk__all_levels(d->width, d->height);
    if (!d->levels) d->levels = d->sampling == GLBK_SAMPLING_MIPMAPS ? most : 1;
    if (d->levels > most) return GLBK_ERR_ARGUMENT;
    if (d->sampling == GLBK_SAMPLING_COMPARE) return glbk__is_depth(d->format) ? GLBK_OK : GLBK_ERR_ARGUMENT;
    if (d->sampling != GLBK_SAMPLING_LINEAR && d->sampling != GLBK_SAMPLING_MIPMAPS) return GLBK_OK;
    if (glbk__is_integer(d->format) || glbk__is_depth(d->format)) return GLBK_ERR_ARGUMENT;
    if (glbk__formats[d->format].type == GLBK_GL_FLOAT && !ctx->float_linear) return GLBK_ERR_ARGUMENT;
    return GLBK_OK;
}

static uint32_t glbk__half(uint32_t size, uint32_t level) { return size >> level ? size >> level : 1; }

/* Storage and parameters of the texture that is bound to target. */
static void glbk__fill_texture(const glbk_context *ctx, const glbk_texture_desc *d, uint32_t target)
{
    const glbk__format_info *f = &glbk__formats[d->format];
    int linear = d->sampling == GLBK_SAMPLING_LINEAR || d->sampling == GLBK_SAMPLING_COMPARE;
    int mipmaps = d->sampling == GLBK_SAMPLING_MIPMAPS, wrap = d->repeat ? 0x2901 : 0x812F;
    uint32_t level;

    for (level = 0; level < d->levels; level++) {
        int32_t width = (int32_t)glbk__half(d->width, level), height = (int32_t)glbk__half(d->height, level);
        const void *data = level == 0 ? d->data : NULL;
        if (d->layers)
            ctx->gl.TexImage3D(target, (int32_t)level, f->internal, width, height, (int32_t)d->layers, 0, f->format,
                               f->type, data);
        else
            ctx->gl.TexImage2D(target, (int32_t)level, f->internal, width, height, 0, f->format, f->type, data);
    }
    ctx->gl.TexParameteri(target, 0x813D /* MAX_LEVEL */, (int32_t)d->levels - 1);
    ctx->gl.TexParameteri(target, 0x2801 /* MIN_FILTER */, mipmaps ? 0x2703 : linear ? 0x2601 : d->levels > 1 ? 0x2700
                                                                                                             : 0x2600);
    ctx->gl.TexParameteri(target, 0x2800 /* MAG_FILTER */, mipmaps || linear ? 0x2601 : 0x2600);
    ctx->gl.TexParameteri(target, 0x2802 /* WRAP_S */, wrap);
    ctx->gl.TexParameteri(target, 0x2803 /* WRAP_T */, wrap);
    if (d->sampling == GLBK_SAMPLING_COMPARE) {
        ctx->gl.TexParameteri(target, 0x884C /* COMPARE_MODE */, 0x884E /* COMPARE_REF_TO_TEXTURE */);
        ctx->gl.TexParameteri(target, 0x884D /* COMPARE_FUNC */, 0x0203 /* LEQUAL */);
    }
    if (mipmaps && d->data) ctx->gl.GenerateMipmap(target);
}

GLBK_DEF glbk_result glbk_texture_create(glbk_context *ctx, const glbk_texture_desc *desc, glbk_texture *out)
{
    glbk_texture_desc d;
    glbk__store store;
    int32_t bound = 0;
    glbk_result result;

    if (!out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    result = glbk__enter(ctx);
    if (result != GLBK_OK) return result;
    if (!desc) return GLBK_ERR_ARGUMENT;
    d = *desc;
    result = glbk__check_texture(ctx, &d);
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
    if (result != GLBK_OK) glbk_texture_destroy(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_texture_update(glbk_context *ctx, const glbk_texture *t, uint32_t level, uint32_t x,
                                         uint32_t y, uint32_t layer, uint32_t width, uint32_t height,
                                         uint32_t layers, const void *data)
{
    const glbk__format_info *f;
    glbk__store store;
    int32_t bound = 0;
    uint32_t wide, high, deep;
    glbk_result result = glbk__enter(ctx);

    if (result != GLBK_OK) return result;
    if (!t || !t->name || !data || level >= t->levels) return GLBK_ERR_ARGUMENT;
    wide = glbk__half(t->width, level);
    high = glbk__half(t->height, level);
    deep = t->layers ? t->layers : 1;
    if (x > wide || width > wide - x || y > high || height > high - y || layer > deep || layers > deep - layer)
        return GLBK_ERR_ARGUMENT;
    f = &glbk__formats[t->format];
    ctx->gl.GetIntegerv(glbk__binding_of(t->gl_target), &bound);
    glbk__store_begin(ctx, GLBK__UNPACK, &store);
    ctx->gl.BindTexture(t->gl_target, t->name);
    if (t->layers)
        ctx->gl.TexSubImage3D(t->gl_target, (int32_t)level, (int32_t)x, (int32_t)y, (int32_t)layer, (int32_t)width,
                              (int32_t)height, (int32_t)layers, f->format, f->type, data);
    else
        ctx->gl.TexSubImage2D(t->gl_target, (int32_t)level, (int32_t)x, (int32_t)y, (int32_t)width, (int32_t)height,
                              f->format, f->type, data);
    ctx->gl.BindTexture(t->gl_target, (uint32_t)bound);
    glbk__store_end(ctx, GLBK__UNPACK, &store);
    return glbk__leave(ctx);
}

GLBK_DEF void glbk_texture_destroy(glbk_context *ctx, glbk_texture *texture)
{
    if (!texture) return;
    if (ctx && !ctx->lost && texture->name) ctx->gl.DeleteTextures(1, &texture->name);
    memset(texture, 0, sizeof *texture);
}

/* ---- >>tables: texel i at (i & 1023, i >> 10 & 1023, i >> 20) ---- */

enum { GLBK__TABLE_BITS = 10, GLBK__TABLE_SIDE = 1 << GLBK__TABLE_BITS };

GLBK_DEF glbk_result glbk_table_create(glbk_context *ctx, glbk_format format, const void *texels, size_t count,
                                       glbk_texture *out)
{
    const size_t side = GLBK__TABLE_SIDE;
    glbk_texture_desc d;
    glbk_result result;
    size_t rows;

    if (!out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!ctx || !count) return GLBK_ERR_ARGUMENT;
    rows = (count - 1) / side + 1;
    if ((rows - 1) / side >= ctx->max_layers) {
        glbk__log_clear(ctx);
        return ctx->lost ? GLBK_ERR_LOST : GLBK_ERR_LIMIT;
    }
    memset(&d, 0, sizeof d);
    d.format = format;
    d.width = GLBK__TABLE_SIDE;
    d.height = (uint32_t)(rows < side ? rows : side);
    d.layers = (uint32_t)((rows - 1) / side + 1);
    result = glbk_texture_create(ctx, &d, out);
    if (result == GLBK_OK && texels) result = glbk_table_update(ctx, out, 0, count, texels);
    if (result != GLBK_OK) glbk_texture_destroy(ctx, out);
    return result;
}

/* A run of texels is up to three boxes in each layer: the rest of a row, whole rows, the beginning of a row. */
GLBK_DEF glbk_result glbk_table_update(glbk_context *ctx, const glbk_texture *table, size_t first, size_t count,
                                       const void *texels)
{
    const size_t side = GLBK__TABLE_SIDE;
    const unsigned char *from = (const unsigned char *)texels;
    size_t room;

    if (!ctx || !table || !table->name || table->width != side || !table->layers || !texels) return GLBK_ERR_ARGUMENT;
    room = side * table->height * table->layers;
    if (first > room || count > room - first) return GLBK_ERR_ARGUMENT;
    while (count) {
        size_t x = first % side, y = first / side % side, layer = first / side / side, width, height = 1;
        glbk_result result;
        if (x || count < side) {
            width = count < side - x ? count : side - x;
        } else {
            width = side;
            height = count / side < side - y ? count / side : side - y;
        }
        result = glbk_texture_update(ctx, table, 0, (uint32_t)x, (uint32_t)y, (uint32_t)layer, (uint32_t)width,
                                     (uint32_t)height, 1, from);
        if (result != GLBK_OK) return result;
        from += width * height * glbk__formats[table->format].bytes;
        first += width * height;
        count -= width * height;
    }
    return GLBK_OK;
}

/* ---- >>buffers: through the copy target, which no vertex array or draw looks at ---- */

GLBK_DEF glbk_result glbk_buffer_create(glbk_context *ctx, size_t size, const void *data, glbk_buffer *out)
{
    int32_t bound = 0;
    glbk_result result;

    if (!out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    result = glbk__enter(ctx);
    if (result != GLBK_OK) return result;
    if (!size) return GLBK_ERR_ARGUMENT;
    if (size > PTRDIFF_MAX) return GLBK_ERR_LIMIT;
    ctx->gl.GetIntegerv(GLBK_GL_COPY_WRITE_BUFFER, &bound);
    ctx->gl.GenBuffers(1, &out->name);
    ctx->gl.BindBuffer(GLBK_GL_COPY_WRITE_BUFFER, out->name);
    ctx->gl.BufferData(GLBK_GL_COPY_WRITE_BUFFER, (ptrdiff_t)size, data, GLBK_GL_STATIC_DRAW);
    ctx->gl.BindBuffer(GLBK_GL_COPY_WRITE_BUFFER, (uint32_t)bound);
    out->size = size;
    result = glbk__leave(ctx);
    if (result != GLBK_OK) glbk_buffer_destroy(ctx, out);
    return result;
}

static int glbk__inside(const glbk_buffer *buffer, size_t offset, size_t size)
{
    return buffer && buffer->name && offset <= buffer->size && size <= buffer->size - offset;
}

GLBK_DEF glbk_result glbk_buffer_update(glbk_context *ctx, const glbk_buffer *buffer, size_t offset, size_t size,
                                        const void *data)
{
    int32_t bound = 0;
    glbk_result result = glbk__enter(ctx);

    if (result != GLBK_OK) return result;
    if (!data || !glbk__inside(buffer, offset, size)) return GLBK_ERR_ARGUMENT;
    ctx->gl.GetIntegerv(GLBK_GL_COPY_WRITE_BUFFER, &bound);
    ctx->gl.BindBuffer(GLBK_GL_COPY_WRITE_BUFFER, buffer->name);
    ctx->gl.BufferSubData(GLBK_GL_COPY_WRITE_BUFFER, (ptrdiff_t)offset, (ptrdiff_t)size, data);
    ctx->gl.BindBuffer(GLBK_GL_COPY_WRITE_BUFFER, (uint32_t)bound);
    return glbk__leave(ctx);
}

GLBK_DEF glbk_result glbk_buffer_read(glbk_context *ctx, const glbk_buffer *buffer, size_t offset, size_t size,
                                      void *out)
{
    int32_t bound = 0;
    glbk_result result = glbk__enter(ctx);

    if (result != GLBK_OK) return result;
    if (!out || !glbk__inside(buffer, offset, size)) return GLBK_ERR_ARGUMENT;
    if (ctx->es) return GLBK_ERR_FEATURE;
    ctx->gl.GetIntegerv(GLBK_GL_COPY_WRITE_BUFFER, &bound);
    ctx->gl.BindBuffer(GLBK_GL_COPY_WRITE_BUFFER, buffer->name);
    ctx->gl.GetBufferSubData(GLBK_GL_COPY_WRITE_BUFFER, (ptrdiff_t)offset, (ptrdiff_t)size, out);
    ctx->gl.BindBuffer(GLBK_GL_COPY_WRITE_BUFFER, (uint32_t)bound);
    return glbk__leave(ctx);
}

GLBK_DEF void glbk_buffer_destroy(glbk_context *ctx, glbk_buffer *buffer)
{
    if (!buffer) return;
    if (ctx && !ctx->lost && buffer->name) ctx->gl.DeleteBuffers(1, &buffer->name);
    memset(buffer, 0, sizeof *buffer);
}

/* ---- >>targets ---- */

/* Checks the attachments and takes their common size. */
static glbk_result glbk__check_target(const glbk_context *ctx, const glbk_target_desc *d, glbk_target *out)
{
    uint32_t i;
    for (i = 0; i <= GLBK_MAX_ATTACHMENTS; i++) {
        int is_color = i < GLBK_MAX_ATTACHMENTS;
        const glbk_texture *t = is_color ? d->color[i] : d->depth;
        uint32_t layer = is_color ? d->layer[i] : d->depth_layer;
        if (!t) continue;
        if (is_color && i != out->count) return GLBK_ERR_ARGUMENT;
        if (!t->name || d->level >= t->levels || layer >= (t->layers ? t->layers : 1)) return GLBK_ERR_ARGUMENT;
        if (is_color == glbk__is_depth(t->format)) return GLBK_ERR_ARGUMENT;
        if (glbk__is_float(t->format) && !ctx->float_targets) return GLBK_ERR_FLOAT_TARGET;
        if (out->width && (out->width != glbk__half(t->width, d->level) ||
                           out->height != glbk__half(t->height, d->level)))
            return GLBK_ERR_ARGUMENT;
        out->width = glbk__half(t->width, d->level);
        out->height = glbk__half(t->height, d->level);
        if (is_color) out->format[out->count++] = t->format;
        else out->has_depth = 1;
    }
    return out->width ? GLBK_OK : GLBK_ERR_ARGUMENT;
}

static void glbk__attach(const glbk_context *ctx, uint32_t attachment, const glbk_texture *t, uint32_t level,
                         uint32_t layer)
{
    if (!t) return;
    if (t->layers)
        ctx->gl.FramebufferTextureLayer(GLBK_GL_DRAW_FRAMEBUFFER, attachment, t->name, (int32_t)level, (int32_t)layer);
    else
        ctx->gl.FramebufferTexture2D(GLBK_GL_DRAW_FRAMEBUFFER, attachment, t->gl_target, t->name, (int32_t)level);
}

GLBK_DEF glbk_result glbk_target_create(glbk_context *ctx, const glbk_target_desc *desc, glbk_target *out)
{
    uint32_t buffers[GLBK_MAX_ATTACHMENTS], i, status;
    int32_t bound = 0;
    glbk_result result;

    if (!out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    result = glbk__enter(ctx);
    if (result != GLBK_OK) return result;
    result = desc ? glbk__check_target(ctx, desc, out) : GLBK_ERR_ARGUMENT;
    if (result != GLBK_OK) {
        memset(out, 0, sizeof *out);
        return result;
    }
    ctx->gl.GetIntegerv(0x8CA6 /* DRAW_FRAMEBUFFER_BINDING */, &bound);
    ctx->gl.GenFramebuffers(1, &out->name);
    ctx->gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, out->name);
    for (i = 0; i < out->count; i++) {
        buffers[i] = GLBK_GL_COLOR_ATTACHMENT0 + i;
        glbk__attach(ctx, buffers[i], desc->color[i], desc->level, desc->layer[i]);
    }
    glbk__attach(ctx, GLBK_GL_DEPTH_ATTACHMENT, desc->depth, desc->level, desc->depth_layer);
    if (!out->count) buffers[0] = 0;
    ctx->gl.DrawBuffers(out->count ? (int32_t)out->count : 1, buffers);
    status = ctx->gl.CheckFramebufferStatus(GLBK_GL_DRAW_FRAMEBUFFER);
    ctx->gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, (uint32_t)bound);
    result = glbk__leave(ctx);
    if (result == GLBK_OK && status != 0x8CD5) {
        glbk__log(ctx, "framebuffer status ");
        glbk__log_number(ctx, status, 16);
        result = GLBK_ERR_TARGET;
    }
    if (result != GLBK_OK) glbk_target_destroy(ctx, out);
    return result;
}

/* Bytes 0..255 at the end of the room for count pixels of four floats become those floats. */
static void glbk__widen(void *rgba, size_t count)
{
    const unsigned char *from = (const unsigned char *)rgba + 12 * count;
    float *to = (float *)rgba, pixel[4];
    size_t i, k;
    for (i = 0; i < count; i++) {       /* a pixel never overwrites one that is still to come */
        for (k = 0; k < 4; k++) pixel[k] = (float)from[4 * i + k] / 255.0f;
        memcpy(to + 4 * i, pixel, sizeof pixel);
    }
}

GLBK_DEF glbk_result glbk_target_read(glbk_context *ctx, const glbk_target *target, uint32_t attachment, uint32_t x,
                                      uint32_t y, uint32_t width, uint32_t height, void *rgba)
{
    glbk__store store;
    int32_t bound = 0, clamp = 0;
    int integer, bytes;
    size_t count = (size_t)width * height;
    glbk_result result = glbk__enter(ctx);

    if (result != GLBK_OK) return result;
    if (!target || !target->name || !rgba || attachment >= target->count) return GLBK_ERR_ARGUMENT;
    if (x > target->width || width > target->width - x || y > target->height || height > target->height - y)
        return GLBK_ERR_ARGUMENT;
    integer = glbk__is_integer(target->format[attachment]);
    bytes = ctx->es && !integer && !glbk__is_float(target->format[attachment]);     /* ES gives no floats of these */
    ctx->gl.GetIntegerv(0x8CAA /* READ_FRAMEBUFFER_BINDING */, &bound);
    ctx->gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, target->name);
    ctx->gl.ReadBuffer(GLBK_GL_COLOR_ATTACHMENT0 + attachment);
    glbk__store_begin(ctx, GLBK__PACK, &store);
    if (!ctx->es) {
        ctx->gl.GetIntegerv(0x891C /* CLAMP_READ_COLOR */, &clamp);
        ctx->gl.ClampColor(0x891C, 0);
    }
    ctx->gl.ReadPixels((int32_t)x, (int32_t)y, (int32_t)width, (int32_t)height, integer ? 0x8D99u : 0x1908u,
                       integer ? GLBK_GL_UNSIGNED_INT : bytes ? GLBK_GL_UNSIGNED_BYTE : GLBK_GL_FLOAT,
                       (unsigned char *)rgba + (bytes ? 12 * count : 0));
    if (!ctx->es) ctx->gl.ClampColor(0x891C, (uint32_t)clamp);
    glbk__store_end(ctx, GLBK__PACK, &store);
    ctx->gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, (uint32_t)bound);
    result = glbk__leave(ctx);
    if (result == GLBK_OK && bytes) glbk__widen(rgba, count);
    return result;
}

GLBK_DEF void glbk_target_destroy(glbk_context *ctx, glbk_target *target)
{
    if (!target) return;
    if (ctx && !ctx->lost && target->name) ctx->gl.DeleteFramebuffers(1, &target->name);
    memset(target, 0, sizeof *target);
}

/* ---- >>glsl: the text of a program ---- */

enum { GLBK__MAX_FILES = 32 };

GLBK_DEF const glbk_file *glbk_files(uint32_t *count)
{
    if (count) *count = (uint32_t)(sizeof glbk__files / sizeof glbk__files[0]);
    return glbk__files;
}

/* "lib/" + "table" + ".glsl" = "lib/table.glsl"; length counts the middle. */
static int glbk__is_named(const char *name, const char *before, const char *middle, size_t length, const char *after)
{
    size_t n = strlen(before);
    return strncmp(name, before, n) == 0 && strncmp(name + n, middle, length) == 0 &&
           strcmp(name + n + length, after) == 0;
}

static const glbk_file *glbk__find(const char *before, const char *middle, size_t length, const char *after)
{
    size_t i;
    for (i = 0; i < sizeof glbk__files / sizeof glbk__files[0]; i++)
        if (glbk__is_named(glbk__files[i].name, before, middle, length, after)) return &glbk__files[i];
    return NULL;
}

GLBK_DEF const glbk_file *glbk_find_file(const char *name)
{
    return name ? glbk__find("", name, strlen(name), "") : NULL;
}

typedef struct glbk__list {
    const glbk_file *file[GLBK__MAX_FILES];
    uint32_t         count;
} glbk__list;

/* Next word of a list separated by blanks; its length, 0 at the end. */
static size_t glbk__word(const char **s)
{
    size_t length = 0;
    while (**s == ' ') (*s)++;
    while ((*s)[length] && (*s)[length] != ' ') length++;
    return length;
}

/* Adds the library files named, each after what it uses itself, none twice. 0 where one is unknown. The depth is that
   of the embedded files, which tests/gl walks. */
static int glbk__gather(glbk__list *list, const char *names)
{
    size_t length;
    uint32_t i;
    for (; (length = glbk__word(&names)) != 0; names += length) {
        const glbk_file *file = glbk__find("lib/", names, length, ".glsl");
        if (!file || !glbk__gather(list, file->uses)) return 0;
        for (i = 0; i < list->count && list->file[i] != file; i++) {}
        if (i < list->count) continue;
        if (list->count == GLBK__MAX_FILES) return 0;
        list->file[list->count++] = file;
    }
    return 1;
}

typedef struct glbk__sink {
    char  *out;
    size_t size, used;
} glbk__sink;

static void glbk__put(glbk__sink *sink, const char *text, size_t length)
{
    size_t room = sink->size > sink->used + 1 ? sink->size - 1 - sink->used : 0;
    if (room > length) room = length;
    if (room) memcpy(sink->out + sink->used, text, room);
    sink->used += length;
}

static void glbk__put_text(glbk__sink *sink, const char *text) { glbk__put(sink, text, strlen(text)); }

/* "#line n001 n": line 4 of file 3 is 3004 in the driver's messages. Mesa forgets the file number, hence the thousands. */
static void glbk__put_line(glbk__sink *sink, uint32_t n)
{
    char digits[] = { (char)('0' + n / 10), (char)('0' + n % 10), 0 };
    const char *number = n < 10 ? digits + 1 : digits;
    glbk__put_text(sink, "#line ");
    glbk__put_text(sink, number);
    glbk__put_text(sink, "001 ");
    glbk__put_text(sink, number);
    glbk__put_text(sink, "\n");
}

static void glbk__put_file(glbk__sink *sink, const glbk_file *file)
{
    uint32_t i;
    for (i = 0; i < file->line_count; i++) glbk__put_text(sink, file->lines[i]);
}

static int glbk__is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
static int glbk__is_value(char c) { return glbk__is_letter(c) || (c >= '0' && c <= '9') || c == '.' || c == '-'; }

/* "A=1 B" becomes "#define A 1", "#define B 1". */
static int glbk__put_defines(glbk__sink *sink, const char *defines)
{
    size_t length;
    for (; (length = glbk__word(&defines)) != 0; defines += length) {
        size_t name = 0, i;
        while (name < length && defines[name] != '=') name++;
        if (!name || !glbk__is_letter(defines[0])) return 0;
        for (i = 0; i < length; i++)
            if (i != name && !glbk__is_value(defines[i])) return 0;
        glbk__put_text(sink, "#define ");
        glbk__put(sink, defines, name);
        glbk__put_text(sink, " ");
        if (name < length) glbk__put(sink, defines + name + 1, length - name - 1);
        else glbk__put_text(sink, "1");
        glbk__put_text(sink, "\n");
    }
    return 1;
}

GLBK_DEF size_t glbk_write_glsl(glbk_dialect dialect, int float_bits, const char *uses, const char *defines,
                                const char *main_name, const char *main_text, char *out, size_t size)
{
    static const char *const versions[] = { "#version 330 core\n", "#version 300 es\n", "#version 430 core\n" };
    const glbk_file *main_file = main_name ? glbk_find_file(main_name) : NULL;
    glbk__list list;
    glbk__sink sink;
    uint32_t i;

    if ((unsigned)dialect >= GLBK_DIALECT_COUNT || (main_name && !main_file) || (!out && size)) return 0;
    list.count = 0;
    if (!glbk__gather(&list, "prelude") || !glbk__gather(&list, uses ? uses : "") ||
        !glbk__gather(&list, main_file ? main_file->uses : ""))
        return 0;
    sink.out = out;
    sink.size = size;
    sink.used = 0;
    glbk__put_text(&sink, versions[dialect]);
    glbk__put_text(&sink, float_bits ? "#define GLBK_FLOAT_BITS 1\n" : "#define GLBK_FLOAT_BITS 0\n");
    if (!glbk__put_defines(&sink, defines ? defines : "")) return 0;
    for (i = 0; i < list.count; i++) {
        glbk__put_line(&sink, i + 1);
        glbk__put_file(&sink, list.file[i]);
    }
    glbk__put_line(&sink, list.count + 1);
    if (main_file) glbk__put_file(&sink, main_file);
    if (main_text) glbk__put_text(&sink, main_text);
    if (size) out[sink.used < size ? sink.used : size - 1] = 0;
    return sink.used + 1;
}

/* ---- >>programs ---- */

enum { GLBK__FRAGMENT = 0x8B30, GLBK__VERTEX = 0x8B31, GLBK__COMPUTE = 0x91B9 };

/* What a stage is made of. */
typedef struct glbk__stage {
    uint32_t    type;
    const char *name, *text;        /* one of them */
} glbk__stage;

/* Which number of the driver's messages is which file. */
static void glbk__log_files(glbk_context *ctx, const char *uses, const glbk__stage *stage)
{
    const glbk_file *main_file = stage->name ? glbk_find_file(stage->name) : NULL;
    glbk__list list;
    uint32_t i;

    list.count = 0;
    if (!glbk__gather(&list, "prelude") || !glbk__gather(&list, uses) ||
        !glbk__gather(&list, main_file ? main_file->uses : ""))
        return;
    glbk__log(ctx, "files: 0 defines");
    for (i = 0; i <= list.count; i++) {
        glbk__log(ctx, ", ");
        glbk__log_number(ctx, i + 1, 10);
        glbk__log(ctx, " ");
        glbk__log(ctx, i < list.count ? list.file[i]->name : stage->name ? stage->name : "your text");
    }
    glbk__log(ctx, "\n");
}

/* The driver's words behind what the log holds already. */
static void glbk__log_driver(glbk_context *ctx, uint32_t object, int is_shader)
{
    size_t used;
    int32_t length = 0;
    if (!ctx->log || !ctx->log_size) return;
    used = strlen(ctx->log);
    if (ctx->log_size - used < 2) return;
    if (is_shader) ctx->gl.GetShaderInfoLog(object, (int32_t)(ctx->log_size - used), &length, ctx->log + used);
    else ctx->gl.GetProgramInfoLog(object, (int32_t)(ctx->log_size - used), &length, ctx->log + used);
    ctx->log[ctx->log_size - 1] = 0;
}

/* Compiles one stage and attaches it. */
static glbk_result glbk__add_stage(glbk_context *ctx, uint32_t program, const glbk__stage *stage, const char *uses,
                                   const char *defines)
{
    glbk_dialect dialect = ctx->es ? GLBK_GLSL_300_ES : stage->type == GLBK__COMPUTE ? GLBK_GLSL_430 : GLBK_GLSL_330;
    glbk__allocator memory = glbk__allocator_make(ctx->allocator.alloc_fn, ctx->allocator.free_fn, ctx->allocator.user);
    int bits = !ctx->float_targets;
    size_t size = glbk_write_glsl(dialect, bits, uses, defines, stage->name, stage->text, NULL, 0);
    char *text;
    uint32_t shader;
    int32_t compiled = 0;

    if (!size) return glbk__fail(ctx, GLBK_ERR_NAME, "an unknown library file, or bad defines: ", uses);
    if (size > INT32_MAX) return GLBK_ERR_LIMIT;
    text = (char *)glbk__alloc(&memory, size);
    if (!text) return GLBK_ERR_ALLOC;
    glbk_write_glsl(dialect, bits, uses, defines, stage->name, stage->text, text, size);
    shader = ctx->gl.CreateShader(stage->type);
    if (shader) {
        const char *const texts[1] = { text };
        ctx->gl.ShaderSource(shader, 1, texts, NULL);
        ctx->gl.CompileShader(shader);
        ctx->gl.GetShaderiv(shader, 0x8B81 /* COMPILE_STATUS */, &compiled);
        if (compiled) {
            ctx->gl.AttachShader(program, shader);
        } else {
            glbk__log_files(ctx, uses, stage);
            glbk__log_driver(ctx, shader, 1);
        }
        ctx->gl.DeleteShader(shader);       /* lives on as long as it is attached */
    }
    glbk__free(&memory, text);
    return compiled ? GLBK_OK : shader ? GLBK_ERR_COMPILE : GLBK_ERR_GL;
}

/* Names of transform feedback, which GL wants as an array. */
static glbk_result glbk__set_outputs(const glbk_context *ctx, uint32_t program, const char *outputs)
{
    char text[512];
    const char *names[16];
    int32_t count = 0;
    size_t length, used = 0;

    for (; (length = glbk__word(&outputs)) != 0; outputs += length) {
        if (count == 16 || length + 1 > sizeof text - used) return GLBK_ERR_ARGUMENT;
        names[count++] = text + used;
        memcpy(text + used, outputs, length);
        text[used + length] = 0;
        used += length + 1;
    }
    if (count) ctx->gl.TransformFeedbackVaryings(program, count, names, GLBK_GL_INTERLEAVED_ATTRIBS);
    return GLBK_OK;
}

static glbk_result glbk__link(glbk_context *ctx, const glbk__stage *stages, int count, const char *uses,
                              const char *defines, const char *outputs, glbk_program *out)
{
    glbk_result result = GLBK_OK, errors;
    int32_t linked = 0;
    int i;

    out->name = ctx->gl.CreateProgram();
    if (!out->name) result = GLBK_ERR_GL;
    for (i = 0; i < count && result == GLBK_OK; i++)
        result = glbk__add_stage(ctx, out->name, &stages[i], uses, defines);
    if (result == GLBK_OK) result = glbk__set_outputs(ctx, out->name, outputs);
    if (result == GLBK_OK) {
        ctx->gl.LinkProgram(out->name);
        ctx->gl.GetProgramiv(out->name, 0x8B82 /* LINK_STATUS */, &linked);
        if (!linked) {
            glbk__log_driver(ctx, out->name, 0);
            result = GLBK_ERR_LINK;
        }
    }
    errors = glbk__leave(ctx);
    if (errors != GLBK_OK) result = errors;
    if (result != GLBK_OK) glbk_program_destroy(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_program_create(glbk_context *ctx, const char *name, const char *defines, glbk_program *out)
{
    glbk__stage stages[2];
    const glbk_file *file, *vertex;
    size_t length;
    glbk_result result;

    if (!out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    result = glbk__enter(ctx);
    if (result != GLBK_OK) return result;
    if (!name) return GLBK_ERR_ARGUMENT;
    length = strlen(name);
    file = glbk__find("prog/", name, length, "");
    if (!file) return glbk__fail(ctx, GLBK_ERR_NAME, "no file prog/", name);
    stages[0].name = file->name;
    stages[0].text = NULL;
    if (length > 5 && strcmp(name + length - 5, ".comp") == 0) {
        if (!ctx->compute) return GLBK_ERR_FEATURE;
        stages[0].type = GLBK__COMPUTE;
        return glbk__link(ctx, stages, 1, "", defines, "", out);
    }
    vertex = glbk__find("prog/", file->with, strlen(file->with), "");
    if (!vertex) return glbk__fail(ctx, GLBK_ERR_NAME, "no program: ", name);
    stages[0].type = GLBK__FRAGMENT;
    stages[1].type = GLBK__VERTEX;
    stages[1].name = vertex->name;
    stages[1].text = NULL;
    return glbk__link(ctx, stages, 2, "", defines, "", out);
}

GLBK_DEF glbk_result glbk_program_compile(glbk_context *ctx, const glbk_source *s, glbk_program *out)
{
    glbk__stage stages[2];
    const char *uses, *outputs;
    glbk_result result;

    if (!out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    result = glbk__enter(ctx);
    if (result != GLBK_OK) return result;
    if (!s || (s->fragment != NULL) == (s->compute != NULL)) return GLBK_ERR_ARGUMENT;
    uses = s->uses ? s->uses : "";
    outputs = s->outputs ? s->outputs : "";
    stages[0].name = NULL;
    if (s->compute) {
        if (!ctx->compute) return GLBK_ERR_FEATURE;
        stages[0].type = GLBK__COMPUTE;
        stages[0].text = s->compute;
        return glbk__link(ctx, stages, 1, uses, s->defines, "", out);
    }
    stages[0].type = GLBK__FRAGMENT;
    stages[0].text = s->fragment;
    stages[1].type = GLBK__VERTEX;
    stages[1].name = s->vertex ? NULL : "prog/screen.vert";
    stages[1].text = s->vertex;
    return glbk__link(ctx, stages, 2, uses, s->defines, outputs, out);
}

GLBK_DEF void glbk_program_destroy(glbk_context *ctx, glbk_program *program)
{
    if (!program) return;
    if (ctx && !ctx->lost && program->name) ctx->gl.DeleteProgram(program->name);
    memset(program, 0, sizeof *program);
}

typedef struct glbk__slot {
    const char *name;
    uint32_t    slot;
} glbk__slot;

/* Each list ends with an entry of its own, since C knows no empty arrays. */
static const glbk__slot glbk__texture_slots[] = {
#define GLBK__ENTRY(type, name, slot) { #name, slot },
#define GLBK__LIST(part, PART) GLBK_##PART##_TEXTURES(GLBK__ENTRY)
    GLBK_PARTS(GLBK__LIST)
#undef GLBK__LIST
#undef GLBK__ENTRY
    { NULL, 0 }
};

static const glbk__slot glbk__block_slots[] = {
#define GLBK__ENTRY(name, slot, members) { #name "_block", slot },
#define GLBK__LIST(part, PART) GLBK_##PART##_BLOCKS(GLBK__ENTRY)
    GLBK_PARTS(GLBK__LIST)
#undef GLBK__LIST
#undef GLBK__ENTRY
    { NULL, 0 }
};

GLBK_DEF void glbk_set_slots(glbk_context *ctx, uint32_t gl_program)
{
    const glbk__slot *s;
    if (!ctx || ctx->lost) return;
    for (s = glbk__texture_slots; s->name; s++) {
        int32_t location = ctx->gl.GetUniformLocation(gl_program, s->name);
        if (location >= 0) ctx->gl.Uniform1i(location, (int32_t)(ctx->first_unit + s->slot));
    }
    for (s = glbk__block_slots; s->name; s++) {
        uint32_t index = ctx->gl.GetUniformBlockIndex(gl_program, s->name);
        if (index != 0xFFFFFFFFu) ctx->gl.UniformBlockBinding(gl_program, index, ctx->first_block + s->slot);
    }
}

GLBK_DEF void glbk_program_use(glbk_context *ctx, glbk_program *program)
{
    if (!ctx || ctx->lost || !program) return;
    ctx->gl.UseProgram(program->name);
    if (!program->slots_set) glbk_set_slots(ctx, program->name);
    program->slots_set = 1;
}

/* ---- >>state: what passes touch ----

   X(group, GL's name, value that a pass needs): BOTH, or DESK for OpenGL alone. PROGRAM_POINT_SIZE, MULTISAMPLE and
   FRAMEBUFFER_SRGB are on because ES has no switch for them and behaves so; the rest must not interfere. */

#define GLBK__CAPS(X)                                                   \
    X(BOTH, 0x0BE2, 0) /* BLEND */                                      \
    X(BOTH, 0x0B71, 0) /* DEPTH_TEST */                                 \
    X(BOTH, 0x0B44, 0) /* CULL_FACE */                                  \
    X(BOTH, 0x8037, 0) /* POLYGON_OFFSET_FILL */                        \
    X(BOTH, 0x0C11, 0) /* SCISSOR_TEST */                               \
    X(BOTH, 0x0B90, 0) /* STENCIL_TEST */                               \
    X(BOTH, 0x0BD0, 0) /* DITHER */                                     \
    X(BOTH, 0x809E, 0) /* SAMPLE_ALPHA_TO_COVERAGE */                   \
    X(BOTH, 0x80A0, 0) /* SAMPLE_COVERAGE */                            \
    X(BOTH, 0x8C89, 0) /* RASTERIZER_DISCARD */                         \
    X(RESTART, 0x8D69, 0) /* PRIMITIVE_RESTART_FIXED_INDEX */           \
    X(DESK, 0x8F9D, 0) /* PRIMITIVE_RESTART */                          \
    X(DESK, 0x0BF2, 0) /* COLOR_LOGIC_OP */                             \
    X(DESK, 0x864F, 0) /* DEPTH_CLAMP */                                \
    X(DESK, 0x809F, 0) /* SAMPLE_ALPHA_TO_ONE */                        \
    X(DESK, 0x8E51, 0) /* SAMPLE_MASK */                                \
    X(DESK, 0x0B41, 0) /* POLYGON_SMOOTH */                             \
    X(DESK, 0x0B20, 0) /* LINE_SMOOTH */                                \
    X(DESK, 0x2A02, 0) /* POLYGON_OFFSET_LINE */                        \
    X(DESK, 0x2A01, 0) /* POLYGON_OFFSET_POINT */                       \
    X(DESK, 0x8642, 1) /* PROGRAM_POINT_SIZE */                         \
    X(DESK, 0x809D, 1) /* MULTISAMPLE */                                \
    X(DESK, 0x8DB9, 1) /* FRAMEBUFFER_SRGB */                           \
    X(DESK, 0x884F, 1) /* TEXTURE_CUBE_MAP_SEAMLESS */                  \
    X(DESK, 0x3000, 0) X(DESK, 0x3001, 0) X(DESK, 0x3002, 0) X(DESK, 0x3003, 0) /* CLIP_DISTANCE */  \
    X(DESK, 0x3004, 0) X(DESK, 0x3005, 0) X(DESK, 0x3006, 0) X(DESK, 0x3007, 0)

enum { GLBK__CAP_BOTH, GLBK__CAP_DESK, GLBK__CAP_RESTART };

static const struct { uint32_t name; int group, value; } glbk__caps[] = {
#define GLBK__ENTRY(group, name, value) { name, GLBK__CAP_##group, value },
    GLBK__CAPS(GLBK__ENTRY)
#undef GLBK__ENTRY
};
enum { GLBK__CAP_COUNT = sizeof glbk__caps / sizeof glbk__caps[0] };

static int glbk__has_cap(const glbk_context *ctx, int i)
{
    if (glbk__caps[i].group == GLBK__CAP_RESTART) return ctx->es || ctx->version >= 430;
    return glbk__caps[i].group == GLBK__CAP_BOTH || !ctx->es;
}

static void glbk__set_cap(const glbk_context *ctx, uint32_t name, int on)
{
    if (on) ctx->gl.Enable(name);
    else ctx->gl.Disable(name);
}

#define GLBK__WORDS(X)                                              \
    X(PROGRAM, 0x8B8D) X(VERTEX_ARRAY, 0x85B5) X(TARGET, 0x8CA6)    \
    X(UNIT, 0x84E0) X(BLOCK, 0x8A28) X(DEPTH_FUNC, 0x0B74)          \
    X(CULL_MODE, 0x0B45) X(FRONT, 0x0B46)                           \
    X(SOURCE_RGB, 0x80C9) X(DEST_RGB, 0x80C8) X(SOURCE_ALPHA, 0x80CB) X(DEST_ALPHA, 0x80CA)     \
    X(EQUATION_RGB, 0x8009) X(EQUATION_ALPHA, 0x883D)

enum {
#define GLBK__ENTRY(name, gl) GLBK__W_##name,
    GLBK__WORDS(GLBK__ENTRY)
#undef GLBK__ENTRY
    GLBK__WORD_COUNT,
    GLBK__W_STORAGE = GLBK__WORD_COUNT, GLBK__W_ORIGIN, GLBK__W_CLIP_DEPTH, GLBK__W_POLYGON, GLBK__W_POLYGON_2
};

static const uint32_t glbk__word_names[] = {
#define GLBK__ENTRY(name, gl) gl,
    GLBK__WORDS(GLBK__ENTRY)
#undef GLBK__ENTRY
};

enum { GLBK__BLEND = 0x0BE2, GLBK__COLOR_MASK = 0x0C23 };

static void glbk__save_indexed(glbk_context *ctx, glbk_state *s)
{
    uint32_t i;
    if (ctx->es) {
        ctx->gl.GetBooleanv(GLBK__COLOR_MASK, s->color_mask[0]);
        return;
    }
    for (i = 0; i < ctx->max_targets; i++) {
        s->blend[i] = ctx->gl.IsEnabledi(GLBK__BLEND, i);
        ctx->gl.GetBooleani_v(GLBK__COLOR_MASK, i, s->color_mask[i]);
    }
}

static void glbk__save_bindings(glbk_context *ctx, glbk_state *s)
{
    uint32_t i;
    for (i = 0; i < GLBK_UNITS; i++) {
        ctx->gl.ActiveTexture(GLBK_GL_TEXTURE0 + ctx->first_unit + i);
        ctx->gl.GetIntegerv(0x8069 /* TEXTURE_BINDING_2D */, &s->units[i][0]);
        ctx->gl.GetIntegerv(0x8C1D /* TEXTURE_BINDING_2D_ARRAY */, &s->units[i][1]);
        ctx->gl.GetIntegerv(0x8919 /* SAMPLER_BINDING */, &s->units[i][2]);
    }
    ctx->gl.ActiveTexture((uint32_t)s->words[GLBK__W_UNIT]);
    for (i = 0; i < GLBK_BLOCKS; i++) {
        ctx->gl.GetIntegeri_v(0x8A28, ctx->first_block + i, &s->blocks[i]);
        ctx->gl.GetInteger64i_v(0x8A29, ctx->first_block + i, &s->ranges[i][0]);
        ctx->gl.GetInteger64i_v(0x8A2A, ctx->first_block + i, &s->ranges[i][1]);
        if (!ctx->compute) continue;
        ctx->gl.GetIntegeri_v(0x90D3, i, &s->storage[i]);
        ctx->gl.GetInteger64i_v(0x90D4, i, &s->storage_ranges[i][0]);
        ctx->gl.GetInteger64i_v(0x90D5, i, &s->storage_ranges[i][1]);
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
    if (ctx->compute) ctx->gl.GetIntegerv(0x90D3, &out->words[GLBK__W_STORAGE]);
    if (ctx->clip_control) {
        ctx->gl.GetIntegerv(0x935C, &out->words[GLBK__W_ORIGIN]);
        ctx->gl.GetIntegerv(0x935D, &out->words[GLBK__W_CLIP_DEPTH]);
    }
    if (!ctx->es) ctx->gl.GetIntegerv(0x0B40, &out->words[GLBK__W_POLYGON]);    /* writes two */
    ctx->gl.GetIntegerv(0x0BA2, out->viewport);
    ctx->gl.GetBooleanv(0x0B72, &out->depth_mask);
    ctx->gl.GetFloatv(0x0B70 /* DEPTH_RANGE */, out->floats);
    ctx->gl.GetFloatv(0x8038 /* POLYGON_OFFSET_FACTOR */, out->floats + 2);
    ctx->gl.GetFloatv(0x2A00 /* POLYGON_OFFSET_UNITS */, out->floats + 3);
    glbk__save_indexed(ctx, out);
    glbk__save_bindings(ctx, out);
}

static void glbk__restore_indexed(glbk_context *ctx, const glbk_state *s)
{
    const uint8_t(*mask)[4] = s->color_mask;
    uint32_t i;
    if (ctx->es) {
        ctx->gl.ColorMask(mask[0][0], mask[0][1], mask[0][2], mask[0][3]);
        return;
    }
    for (i = 0; i < ctx->max_targets; i++) {
        if (s->blend[i]) ctx->gl.Enablei(GLBK__BLEND, i);
        else ctx->gl.Disablei(GLBK__BLEND, i);
        ctx->gl.ColorMaski(i, mask[i][0], mask[i][1], mask[i][2], mask[i][3]);
    }
}

static void glbk__restore_range(glbk_context *ctx, uint32_t target, uint32_t index, int32_t name,
                                const int64_t range[2])
{
    if (name && range[1]) ctx->gl.BindBufferRange(target, index, (uint32_t)name, (ptrdiff_t)range[0], (ptrdiff_t)range[1]);
    else ctx->gl.BindBufferBase(target, index, (uint32_t)name);
}

static void glbk__restore_bindings(glbk_context *ctx, const glbk_state *s)
{
    uint32_t i;
    for (i = 0; i < GLBK_UNITS; i++) {
        ctx->gl.ActiveTexture(GLBK_GL_TEXTURE0 + ctx->first_unit + i);
        ctx->gl.BindTexture(GLBK_GL_TEXTURE_2D, (uint32_t)s->units[i][0]);
        ctx->gl.BindTexture(GLBK_GL_TEXTURE_2D_ARRAY, (uint32_t)s->units[i][1]);
        ctx->gl.BindSampler(ctx->first_unit + i, (uint32_t)s->units[i][2]);
    }
    ctx->gl.ActiveTexture((uint32_t)s->words[GLBK__W_UNIT]);
    for (i = 0; i < GLBK_BLOCKS; i++) {
        glbk__restore_range(ctx, GLBK_GL_UNIFORM_BUFFER, ctx->first_block + i, s->blocks[i], s->ranges[i]);
        if (ctx->compute)
            glbk__restore_range(ctx, GLBK_GL_SHADER_STORAGE_BUFFER, i, s->storage[i], s->storage_ranges[i]);
    }
    ctx->gl.BindBuffer(GLBK_GL_UNIFORM_BUFFER, (uint32_t)s->words[GLBK__W_BLOCK]);
    if (ctx->compute) ctx->gl.BindBuffer(GLBK_GL_SHADER_STORAGE_BUFFER, (uint32_t)s->words[GLBK__W_STORAGE]);
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
    if (!ctx->es) ctx->gl.PolygonMode(0x0408, (uint32_t)w[GLBK__W_POLYGON]);
    ctx->gl.Viewport(state->viewport[0], state->viewport[1], state->viewport[2], state->viewport[3]);
    ctx->gl.DepthMask(state->depth_mask);
    glbk__depth_range(ctx, state->floats[0], state->floats[1]);
    ctx->gl.PolygonOffset(state->floats[2], state->floats[3]);
    glbk__restore_indexed(ctx, state);
    glbk__restore_bindings(ctx, state);
}

/* ---- >>passes ---- */

static void glbk__set_depth(const glbk_context *ctx, glbk_depth depth)
{
    static const uint32_t functions[] = { 0x0207, 0x0201, 0x0203, 0x0202, 0x0204 };
    glbk__set_cap(ctx, 0x0B71, depth != GLBK_DEPTH_OFF);
    ctx->gl.DepthMask(depth != GLBK_DEPTH_OFF && depth != GLBK_DEPTH_EQUAL);
    ctx->gl.DepthFunc(functions[depth]);
}

static void glbk__set_blend(const glbk_context *ctx, glbk_blend blend)
{
    static const uint32_t equations[] = { 0x8006, 0x8006, 0x8007, 0x8008, 0x8006 };
    if (blend == GLBK_BLEND_OFF) return;
    ctx->gl.Enable(GLBK__BLEND);
    ctx->gl.BlendEquationSeparate(equations[blend], equations[blend]);
    if (blend == GLBK_BLEND_OVER) ctx->gl.BlendFuncSeparate(0x0302, 0x0303, 1, 0x0303);
    else ctx->gl.BlendFuncSeparate(1, 1, 1, 1);
}

static void glbk__set_cull(const glbk_context *ctx, glbk_cull cull)
{
    ctx->gl.FrontFace(0x0901 /* CCW */);
    if (cull == GLBK_CULL_OFF) return;
    ctx->gl.Enable(0x0B44);
    ctx->gl.CullFace(cull == GLBK_CULL_BACK ? 0x0405u : 0x0404u);
}

GLBK_DEF glbk_result glbk_begin(glbk_context *ctx, const glbk_pass *pass, glbk_program *program)
{
    const int32_t *v;
    uint8_t color;
    int i;

    if (!ctx || !pass || (unsigned)pass->depth >= GLBK_DEPTH_COUNT || (unsigned)pass->blend >= GLBK_BLEND_COUNT ||
        (unsigned)pass->cull >= GLBK_CULL_COUNT || (pass->target && !pass->target->name))
        return GLBK_ERR_ARGUMENT;
    if (ctx->lost) return GLBK_ERR_LOST;
    v = pass->viewport;
    if (v[2] < 0 || v[3] < 0 || (!pass->target && (!v[2] || !v[3]))) return GLBK_ERR_ARGUMENT;

    for (i = 0; i < GLBK__CAP_COUNT; i++)
        if (glbk__has_cap(ctx, i)) glbk__set_cap(ctx, glbk__caps[i].name, glbk__caps[i].value);
    if (pass->target) ctx->gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, pass->target->name);
    if (v[2] || v[3]) ctx->gl.Viewport(v[0], v[1], v[2], v[3]);
    else ctx->gl.Viewport(0, 0, (int32_t)pass->target->width, (int32_t)pass->target->height);
    glbk__set_depth(ctx, pass->depth);
    glbk__set_blend(ctx, pass->blend);
    glbk__set_cull(ctx, pass->cull);
    color = !pass->no_color;
    ctx->gl.ColorMask(color, color, color, color);
    glbk__depth_range(ctx, 0, 1);
    if (pass->offset[0] != 0 || pass->offset[1] != 0) {
        ctx->gl.Enable(0x8037);
        ctx->gl.PolygonOffset(pass->offset[0], pass->offset[1]);
    }
    if (!ctx->es) ctx->gl.PolygonMode(0x0408, 0x1B02 /* FILL */);
    if (ctx->clip_control) ctx->gl.ClipControl(0x8CA1 /* LOWER_LEFT */, 0x935E /* NEGATIVE_ONE_TO_ONE */);
    ctx->gl.BindVertexArray(ctx->vertex_array);
    glbk_program_use(ctx, program);
    return GLBK_OK;
}

GLBK_DEF void glbk_clear(glbk_context *ctx, const glbk_target *target, uint32_t attachment, const float rgba[4])
{
    if (!ctx || ctx->lost || !target || attachment >= target->count || !rgba) return;
    if (glbk__is_integer(target->format[attachment])) {
        int bits = target->format[attachment] == GLBK_FORMAT_RGBA32UI && !ctx->float_targets;
        uint32_t words[4];
        int i;
        for (i = 0; i < 4; i++) words[i] = rgba[i] > 0 ? (uint32_t)((double)rgba[i] + 0.5) : 0;
        if (bits) memcpy(words, rgba, sizeof words);
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
    if (!ctx || ctx->lost || !texture || !texture->name || slot >= GLBK_UNITS) return;
    ctx->gl.ActiveTexture(GLBK_GL_TEXTURE0 + ctx->first_unit + slot);
    ctx->gl.BindTexture(texture->gl_target, texture->name);
    ctx->gl.BindSampler(ctx->first_unit + slot, 0);
}

GLBK_DEF void glbk_bind_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer)
{
    if (!ctx || ctx->lost || !buffer || slot >= GLBK_BLOCKS) return;
    ctx->gl.BindBufferBase(GLBK_GL_UNIFORM_BUFFER, ctx->first_block + slot, buffer->name);
}

GLBK_DEF void glbk_bind_storage(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer)
{
    if (!ctx || ctx->lost || !ctx->compute || !buffer || slot >= GLBK_BLOCKS) return;
    ctx->gl.BindBufferBase(GLBK_GL_SHADER_STORAGE_BUFFER, slot, buffer->name);
}

GLBK_DEF void glbk_draw_screen(glbk_context *ctx)
{
    if (ctx && !ctx->lost) ctx->gl.DrawArrays(GLBK_GL_TRIANGLES, 0, 3);
}

GLBK_DEF glbk_result glbk_dispatch(glbk_context *ctx, glbk_program *program, uint32_t x, uint32_t y, uint32_t z)
{
    if (!ctx || !program || !program->name) return GLBK_ERR_ARGUMENT;
    if (ctx->lost) return GLBK_ERR_LOST;
    if (!ctx->compute) return GLBK_ERR_FEATURE;
    glbk_program_use(ctx, program);
    ctx->gl.DispatchCompute(x, y, z);
    ctx->gl.Barrier(GLBK_GL_ALL_BARRIER_BITS);
    return GLBK_OK;
}

/* ---- techniques: one section each; src/README.md says how ---- */

/* ---- end of the techniques ---- */

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
