/* gl_backend.h - v0.9.0 - Dapple's techniques on OpenGL 3.3, OpenGL ES 3.0 and WebGL 2 - MIT-0 OR Unlicense

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

   A picture drawn by a shader of your own that calls a function of the library: examples/06_csm_gl_minimal.c (07 to 10
   of the other techniques). It wants csm.h and GLFW beside this file, and a display: without one xvfb-run -a before it.

   Conventions

   Matrices column-major float[16]; GL names are uint32_t; rows of textures from the bottom up, as GL has them. Clip
   depth is GL's -1..1: passes set it back where a context has clip control.

     file       a piece of GLSL in this header: a library file (functions) or a program's main
     set        defines that a program is compiled with: "FILTER=1 COUNT=4"
     slot       number of a texture unit, uniform block, storage buffer or image as the lists of bindings give it; the
                context adds desc.first_unit to those of textures and desc.first_block to those of uniform blocks
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

   Memory, errors, threads, determinism

   Memory comes from the allocator in the desc, only while a program is compiled and by calls that say so. Every
   function that can fail returns a glbk_result; where it is not GLBK_OK its outputs are zeroed, GL objects made on the
   way are deleted, and the log that you gave holds the driver's words or the name of what is missing. Calls that
   create, compile or read refuse to start while a GL error is pending (GLBK_ERR_PENDING), so none of yours gets lost or
   blamed on us. Those of a frame (_update, _upload, _place, _object, _render, _shade, ...) do not ask for GL's error
   flag, which would wait for the driver: they return what they see by themselves. Call glbk_check once a frame, or set
   desc.check while you look for an error: then all of them ask, before and after.
   Creating, updating, reading and destroying leave every GL state as they found it; passes change what
   docs/gl-state.md lists, and glbk_state_save and glbk_state_restore bring it back. Objects are destroyed explicitly;
   destroying accepts NULL, zeroed and half-built objects and, after glbk_abandon or GLBK_ERR_LOST, calls no GL.
   A context and its objects belong to the thread where the GL context is current. No globals.

   Cost: docs/performance.md.   State: docs/gl-state.md.   History: CHANGELOG.md.   Licence: end of this file. */
#ifndef GL_BACKEND_H
#define GL_BACKEND_H

#define GLBK_VERSION 900 /* major * 10000 + minor * 100 + patch */

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
    X(CORE, void, Finish, (void))                                                                                    \
    X(ES, void, DepthRangef, (float from, float to))                                                                 \
    X(ES, void, TexStorage2D, (uint32_t target, int32_t levels, uint32_t format, int32_t width, int32_t height))     \
    X(ES, void, TexStorage3D, (uint32_t target, int32_t levels, uint32_t format, int32_t width, int32_t height,      \
                               int32_t depth))                                                                       \
    X(DESK, void, DepthRange, (double from, double to))                                                              \
    X(DESK, void, PolygonMode, (uint32_t face, uint32_t mode))                                                       \
    X(DESK, void, PointSize, (float size))                                                                           \
    X(DESK, void, ClampColor, (uint32_t target, uint32_t clamp))                                                     \
    X(TARGETS, void, ColorMaski, (uint32_t index, uint8_t r, uint8_t g, uint8_t b, uint8_t a)) /* 3.3, ES 3.2 */     \
    X(TARGETS, void, GetBooleani_v, (uint32_t name, uint32_t index, uint8_t *out))                                   \
    X(TARGETS, void, Enablei, (uint32_t cap, uint32_t index))                                                        \
    X(TARGETS, void, Disablei, (uint32_t cap, uint32_t index))                                                       \
    X(TARGETS, uint8_t, IsEnabledi, (uint32_t cap, uint32_t index))                                                  \
    X(BLENDS, void, BlendEquationSeparatei, (uint32_t index, uint32_t rgb, uint32_t alpha)) /* 4.0, ES 3.2 */        \
    X(BLENDS, void, BlendFuncSeparatei, (uint32_t index, uint32_t srgb, uint32_t drgb, uint32_t salpha,              \
                                         uint32_t dalpha))                                                           \
    X(DESK, void, GetBufferSubData, (uint32_t target, ptrdiff_t offset, ptrdiff_t size, void *out))                  \
    X(COMPUTE, void, DispatchCompute, (uint32_t x, uint32_t y, uint32_t z))                                          \
    X(COMPUTE, void, DispatchComputeIndirect, (ptrdiff_t offset))                                                    \
    X(COMPUTE, void, BindImageTexture, (uint32_t unit, uint32_t texture, int32_t level, uint8_t layered,             \
                                        int32_t layer, uint32_t access, uint32_t format))                            \
    X(COMPUTE, void, Barrier, (uint32_t bits)) /* glMemoryBarrier: windows.h has a macro of that name */              \
    X(CLIP, void, ClipControl, (uint32_t origin, uint32_t depth)) /* 4.5 or an extension, of ES too */                \
    X(CLAMP, void, PolygonOffsetClamp, (float factor, float units, float clamp)) /* 4.6 or an extension */

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
    void *(*alloc_fn)(size_t size, void *user);   /* aligned like malloc's (8 bytes suffice), or NULL */
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
    uint32_t       first_block;     /* likewise bindings of uniform blocks, first_block .. + 7; storage buffers and
                                       images, of compute alone, are always at 0 .. 7, as GLSL says their numbers */
    glbk_allocator allocator;
    int            check;           /* not 0: calls of a frame ask for GL's error flag, too; slow, to look for errors */
} glbk_desc;                        /* zero it, then set what you care about */

typedef struct glbk_context {
    glbk_functions gl;              /* gl.BindTexture(...): yours to call, too */
    const char    *renderer;        /* the driver's, valid while the context lives */
    int            es;              /* OpenGL ES or WebGL */
    int            webgl;           /* primitives always restart there: nothing to switch or to save */
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
    int            each_target;     /* colour mask and blending are switched for each target */
    int            each_blend;      /* ... and have functions of their own */
    int            offset_clamp;
    int            check;           /* desc.check */
    size_t         max_storage;     /* bytes of a storage buffer */
} glbk_context;

#define GLBK_UNITS 16u              /* slots of textures, of uniform blocks, of storage buffers */
#define GLBK_BLOCKS 8u
#define GLBK_IMAGES 8u              /* slots of images, for compute */

GLBK_DEF glbk_result glbk_init(glbk_context *ctx, const glbk_desc *desc);
/* Loads the functions, decides what the current context can do, makes one empty vertex array.
   ctx      yours; may be moved in memory; zeroed on errors
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_CONTEXT; GLBK_ERR_VERSION; GLBK_ERR_FUNCTION, its name in the log;
            GLBK_ERR_LIMIT where first_unit or first_block reach beyond what the context has; GLBK_ERR_PENDING,
            GLBK_ERR_LOST, GLBK_ERR_GL, GLBK_ERR_GL_MEMORY */

GLBK_DEF void glbk_destroy(glbk_context *ctx);
/* Deletes what glbk_init made and zeroes ctx. Destroy textures and the like before. Accepts NULL. */

GLBK_DEF void glbk_abandon(glbk_context *ctx);
/* The GL context is gone or not current: from now on destroying calls touch memory only, all others return
   GLBK_ERR_LOST. */

GLBK_DEF glbk_result glbk_check(glbk_context *ctx);
/* GL's error flag as a result, with its number in the log; once a frame, since passes and updates do not ask for it
   (unless desc.check is set). It is what notices a lost context. */

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
    GLBK_SAMPLING_MIPMAPS,          /* linear, and between levels; they are generated on creation from data, those of
                                       floats where ctx->float_targets */
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
/* Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_LIMIT; GLBK_ERR_FLOAT_TARGET, for mipmaps; GLBK_ERR_GL_MEMORY,
            GLBK_ERR_PENDING, GLBK_ERR_GL, GLBK_ERR_LOST: these four hold for every function below that creates,
            compiles or reads; of the others GLBK_ERR_LOST alone does, and all four with desc.check */

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
/* size > 0 bytes; data NULL = undefined. For any purpose, one after another too, but indices. */
GLBK_DEF glbk_result glbk_indices_create(glbk_context *ctx, size_t size, const void *data, glbk_buffer *out);
/* The same for indices alone: WebGL allows them in no buffer that was bound to anything else first. */
GLBK_DEF glbk_result glbk_buffer_update(glbk_context *ctx, const glbk_buffer *buffer, size_t offset, size_t size,
                                        const void *data);
/* Of the whole buffer in one call is best: it gets new storage, so that nothing waits for draws from the old. */
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
    const char *uses;               /* library files by their bare names, in order, without what they use themselves;
                                       uniform blocks of the library that your text names are found */
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

enum { GLBK_SLOT_glbk_user0 = 12, GLBK_SLOT_glbk_user1, GLBK_SLOT_glbk_user2, GLBK_SLOT_glbk_user3 };

GLBK_DEF void glbk_set_slots(glbk_context *ctx, uint32_t gl_program);
/* The same for a program that you linked yourself and that is in use: every texture and block of our lists that it
   declares gets its slot, samplers of yours that are called glbk_user0 to glbk_user3 those above. Beside the functions
   for your own shaders these are free; not beside lib/ism_gbuffer.glsl and the programs of rsm and ism themselves:
   glbk_rsm_history, _motion and _albedo_map have 12 to 14, ism's G-buffer and light 11 to 15. */

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
    const glbk_target *target;      /* NULL = the framebuffer that is bound; then the viewport must be given, and
                                       FRAMEBUFFER_SRGB is as you have set it: no pass encodes colours by itself */
    int32_t            viewport[4]; /* x, y, width, height; all zero = the whole target */
    glbk_depth         depth;
    glbk_blend         blend;
    glbk_cull          cull;
    int                no_color;    /* not 0: writes depth only */
    float              offset[2];   /* of depth: factor and units of glPolygonOffset; both 0 = off */
} glbk_pass;                        /* all zero but the target: overwrite everything */

/* The techniques' glbk_..._resolve draw a picture one texel a pixel, its lower left corner at the viewport's. A smaller
   viewport cuts it off; a larger one, or a larger target without a viewport, is GLBK_ERR_ARGUMENT: nothing is scaled.
   To show a picture in another size, resolve to a target of its own size and draw that. */

GLBK_DEF glbk_result glbk_begin(glbk_context *ctx, const glbk_pass *pass, glbk_program *program);
/* Sets every state that a draw depends on, so that nothing inherited shows; binds target and program and the empty
   vertex array. Bind textures and blocks after it. docs/gl-state.md lists what is touched.
   program  NULL where you use your own
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_LOST; GL's error flag is not asked */

GLBK_DEF void glbk_clear(glbk_context *ctx, const glbk_target *target, uint32_t attachment, const float rgba[4]);
/* After glbk_begin to that target. Integer formats get the numbers, rounded, within 0 and 2^32 - 1; GLBK_FORMAT_COLOR
   the floats. */
GLBK_DEF void glbk_clear_depth(glbk_context *ctx, float depth);
/* After glbk_begin with a depth mode that writes. */

GLBK_DEF void glbk_bind_texture(glbk_context *ctx, uint32_t slot, const glbk_texture *texture);
/* To a slot of the lists (GLBK_SLOT_name), without a sampler object. There are 16 slots, from ctx->first_unit on: bind
   textures of your own beyond them yourself. A slot above 15 does nothing.
   texture   NULL or not created: the unit gets no texture, for a sampler that is declared and not read. What others
             left there may be of another kind than the sampler, and WebGL then refuses to draw. */
GLBK_DEF void glbk_bind_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer);
/* The whole buffer as uniform block. */
GLBK_DEF void glbk_bind_storage(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer);
/* The whole buffer as storage buffer; with ctx->compute only. */
GLBK_DEF void glbk_bind_image(glbk_context *ctx, uint32_t slot, const glbk_texture *texture);
/* Level 0, all layers, to read and to write from compute shaders; with ctx->compute only. Its format is the shader's
   layout: rgba32f for GLBK_FORMAT_COLOR. Not RG of 8 bits, not sRGB, not depth. */

GLBK_DEF void glbk_draw_screen(glbk_context *ctx);
/* One triangle over the whole viewport: after glbk_begin. */

GLBK_DEF glbk_result glbk_dispatch(glbk_context *ctx, glbk_program *program, uint32_t x, uint32_t y, uint32_t z);
/* Runs x * y * z groups of a compute program and makes what it wrote visible to everything after it.
   Errors   GLBK_ERR_FEATURE, GLBK_ERR_LOST */

GLBK_DEF glbk_result glbk_dispatch_indirect(glbk_context *ctx, glbk_program *program, const glbk_buffer *groups,
                                            size_t offset);
/* The same with x, y, z as three uint32_t at that byte of a buffer, which a shader may have written.
   offset   a multiple of 4
   Errors   GLBK_ERR_FEATURE, GLBK_ERR_LOST */

/* ---- state ---- */

typedef struct glbk_state {         /* private: what glbk_begin and the binding calls may change */
    uint8_t  caps[32], blend[8];
    uint8_t  color_mask[8][4], depth_mask;
    int32_t  words[24];
    int32_t  viewport[4];
    float    floats[4];
    int32_t  units[GLBK_UNITS][3];
    int32_t  blocks[GLBK_BLOCKS], storage[GLBK_BLOCKS];
    int64_t  ranges[GLBK_BLOCKS][2], storage_ranges[GLBK_BLOCKS][2];
    int32_t  images[GLBK_IMAGES][6];
    int32_t  blends[8][6];
    float    offset_clamp;
} glbk_state;

GLBK_DEF void glbk_state_save(glbk_context *ctx, glbk_state *out);
GLBK_DEF void glbk_state_restore(glbk_context *ctx, const glbk_state *state);
/* Round a pass or a whole frame of them, where the rest of your renderer relies on its state. What was bound must not
   be deleted in between; a program that you had deleted while it was in use is gone (0) afterwards, as GL says. */

/* ---- bindings ----

   Each part (technique) has four lists, empty where it needs none, and is itself named in GLBK_PARTS:

     GLBK_part_TEXTURES(X)   X(GLSL type, name, slot)
     GLBK_part_BLOCKS(X)     X(name, slot, MEMBERS), each with a list MEMBERS(X): X(GLSL type, name, count)
     GLBK_part_STORAGE(X)    X(qualifiers, GLSL type, name, slot), an array without size, for compute
     GLBK_part_IMAGES(X)     X(qualifiers, format, GLSL type, name, slot), for compute

   Slots of textures count from 0 to GLBK_UNITS - 1, those of blocks, storage and images to 7, anew in each part: one
   program uses one part, base being one too. From the lists come GLBK_SLOT_name, the C struct of each block (std140:
   only mat4, vec4, ivec4, uvec4 and arrays of them, so that both layouts are the same), and the library file
   "part_bindings". Members are read as block.member. */

#define GLBK_PARTS(X) X(base, BASE) X(csm, CSM) X(sfield, SFIELD) X(envsh, ENVSH) X(rsm, RSM) X(ism, ISM)

#define GLBK_BASE_TEXTURES(X) X(glbk_color_sampler, glbk_source, 0)
#define GLBK_BASE_BLOCKS(X)
#define GLBK_BASE_STORAGE(X)
#define GLBK_BASE_IMAGES(X)

#define GLBK__SLOT_TEXTURE(type, name, slot) GLBK_SLOT_##name = slot,
#define GLBK__SLOT_BLOCK(name, slot, members) GLBK_SLOT_##name = slot,
#define GLBK__SLOT_STORAGE(qualifiers, type, name, slot) GLBK_SLOT_##name = slot,
#define GLBK__SLOT_IMAGE(qualifiers, format, type, name, slot) GLBK_SLOT_##name = slot,
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
        GLBK_##PART##_IMAGES(GLBK__SLOT_IMAGE)      \
        GLBK__LAST_SLOT_##PART                  \
    };                                          \
    GLBK_##PART##_BLOCKS(GLBK__STRUCT)
GLBK__PART(BASE)

/* ---- techniques: one section each; src/README.md says how ---- */

/* ---- csm: coherent shadow maps, after csm.h ----

   Blocks of csm.h are uploaded as they are (cohsm_data), all of a scene into one table; up to 16 instances are in a
   uniform block, more in a table of their own, so that moving them leaves the blocks alone. docs/gpu-layouts.md has all
   layouts, for those who bring their own API. Then the complete renderer of the paper's section 5. Enumerations have
   csm.h's numbers, but 0 of glbk_csm_brdf. For shaders of your own, lib/csm_visible.glsl with glbk_csm_bind:

       cohsm_query cohsm_ask(int light, int filtering, float bias);       // COHSM_LIGHT_*, COHSM_FILTER_*; map pixels
       float csm_visible(uint self, cohsm_query query, vec3 point, vec3 light);

   self: the instance that the point lies on, or COHSM_NO_SELF; point: world; light: by COHSM_LIGHT_DIRECTION the unit
   direction to it, _POSITION a place, _PARAMETER coordinates in 0..1, _INDEX uintBitsToFloat(cell) in x. Result: 1 lit,
   0 dark, between with PCF, -1 refused. Roulette: set query.seed, and query.id anew for each sample. */

#define GLBK_CSM_TEXTURES(X)                                                                        \
    X(usampler2DArray, glbk_csm_blocks, 0)                                                          \
    X(usampler2DArray, glbk_csm_lights, 1)      /* lights, lobes, patterns */                       \
    X(usampler2D, glbk_csm_place, 2)            /* G-buffer */                                      \
    X(usampler2D, glbk_csm_normal, 3)                                                               \
    X(usampler2D, glbk_csm_color, 4)                                                                \
    X(usampler2D, glbk_csm_gloss, 5)                                                                \
    X(glbk_color_sampler, glbk_csm_sum, 6)                                                          \
    X(sampler2D, glbk_csm_color_map, 7)                                                             \
    X(sampler2D, glbk_csm_gloss_map, 8)                                                             \
    X(sampler2D, glbk_csm_normal_map, 9)                                                            \
    X(usampler2DArray, glbk_csm_questions, 10)                                                      \
    X(usampler2DArray, glbk_csm_instances, 11)  /* where there are many */                          \
    X(usampler2D, glbk_csm_layer0, 2)           /* building: depth layers of a batch of views */    \
    X(usampler2D, glbk_csm_layer1, 3)                                                               \
    X(usampler2D, glbk_csm_layer2, 4)                                                               \
    X(usampler2D, glbk_csm_opened, 5)           /* building: the open segment of each pixel */

#define GLBK_CSM_SCENE_MEMBERS(X)                                                                   \
    X(uvec4, table, 1)          /* 0; count; 1: they are in the block; 0 */                         \
    X(uvec4, instances, 176)    /* up to 16: the record, then texels 1 to 7 of the block */

#define GLBK_CSM_FRAME_MEMBERS(X)                                                                   \
    X(uvec4, light, 1)          /* texel of the light; 0; instances; ask */                         \
    X(uvec4, sampling, 1)       /* S, seed, frame, sampling */                                      \
    X(uvec4, range, 1)          /* samples from, to (resolving: corner); filter; seed of roulette */ \
    X(uvec4, tables, 1)         /* texel of the patterns; planes; width, height */                  \
    X(vec4, query, 1)           /* bias; offset; 1 / frames; 0 = the sum begins here */             \
    X(vec4, eye, 1)                                                                                 \
    X(vec4, planes, 8)

#define GLBK_CSM_OBJECT_MEMBERS(X)                                                                  \
    X(mat4, world, 1)                                                                               \
    X(mat4, clip, 1)                                                                                \
    X(uvec4, kinds, 1)          /* BRDF; instance; 1 + plane; which maps */                         \
    X(uvec4, lobes, 1)                                                                              \
    X(vec4, diffuse, 1)                                                                             \
    X(vec4, gloss, 1)                                                                               \
    X(vec4, eye, 1)

#define GLBK_CSM_PEEL_MEMBERS(X)                                                                    \
    X(mat4, view, 1)            /* object to pixels of the tile, depth or w */                      \
    X(vec4, values, 1)          /* 2 / size; depth of w = 1, or 0; open thickness */                \
    X(uvec4, tiles, 1)          /* size of a tile, tiles in a row, views */                         \
    X(uvec4, how, 1)            /* top of the grid; far; positional; self_only */

#define GLBK_CSM_BLOCKS(X)                              \
    X(glbk_csm_scene, 0, GLBK_CSM_SCENE_MEMBERS)        \
    X(glbk_csm_frame, 1, GLBK_CSM_FRAME_MEMBERS)        \
    X(glbk_csm_object, 2, GLBK_CSM_OBJECT_MEMBERS)      \
    X(glbk_csm_peel, 3, GLBK_CSM_PEEL_MEMBERS)

#define GLBK_CSM_STORAGE(X)                             \
    X(readonly, uvec4, glbk_csm_asked, 1)               \
    X(writeonly, float, glbk_csm_answers, 2)            \
    X(restrict, uvec4, glbk_csm_records, 3)

#define GLBK_CSM_IMAGES(X)      X(restrict, rgba32f, image2D, glbk_csm_total, 0)     /* the sum, by compute */

GLBK__PART(CSM)

#define GLBK_CSM_NO_SELF 0xffffffffu
#define GLBK_CSM_MAX_PLANES 8u

typedef struct glbk_csm_block { const void *data; size_t size; } glbk_csm_block;    /* what cohsm_data returns */

typedef struct glbk_csm_instance {
    uint32_t start;             /* of its block: what glbk_csm_maps_create returned */
    float    transform[16];     /* object to world: rotation, one scale > 0, translation */
    float    offset;            /* world units that receivers on it move along their geometric normal, in the
                                   renderer */
} glbk_csm_instance;

typedef struct glbk_csm_maps {  /* read only; zeroed = none. Blocks and instances of one scene */
    glbk_texture blocks;
    glbk_buffer  scene;
    uint32_t     texels, capacity, count;       /* texels: of all blocks */
    char         defines[80];   /* what all blocks have in common, for glbk_csm_bind */
    uint32_t     key, near_count, starts[16], heads[16][28];
    glbk_texture instances;     /* none where they fit in the uniform block */
} glbk_csm_maps;

GLBK_DEF glbk_result glbk_csm_maps_create(glbk_context *ctx, const glbk_csm_block *blocks, size_t count,
                                          uint32_t capacity, uint32_t *starts, glbk_csm_maps *out);
/* Uploads blocks, bytes as they are. No more than 4 GB and ctx->max_layers layers of 16 MB; 256 are guaranteed.
   capacity   instances there is room for
   starts     receives for each block where it begins, for glbk_csm_instance
   Errors     GLBK_ERR_ARGUMENT (not a csm block of format 1), GLBK_ERR_LIMIT */

GLBK_DEF glbk_result glbk_csm_maps_place(glbk_context *ctx, glbk_csm_maps *maps, const glbk_csm_instance *instances,
                                         uint32_t count);
/* All instances of the scene, each time that one moves: one upload.
   Errors   GLBK_ERR_ARGUMENT, where a transform shears, mirrors or scales unevenly, too; GLBK_ERR_ALLOC, of many */

GLBK_DEF void glbk_csm_bind(glbk_context *ctx, const glbk_csm_maps *maps);
/* For a program of yours with csm_visible among its library files, which is bound: textures and uniform block. One
   compiled with maps->defines among its own is much faster (one domain, one order, one frame, no table of instances),
   but is for maps with the same defines only. */

GLBK_DEF void glbk_csm_maps_destroy(glbk_context *ctx, glbk_csm_maps *maps);

typedef enum glbk_csm_ask {     /* what a light's samples ask the maps by: cohsm_light */
    GLBK_CSM_ASK_DIRECTION, GLBK_CSM_ASK_POSITION, GLBK_CSM_ASK_PARAMETER, GLBK_CSM_ASK_INDEX, GLBK_CSM_ASK_COUNT
} glbk_csm_ask;

typedef enum glbk_csm_filter {  /* cohsm_filter */
    GLBK_CSM_FILTER_NEAREST, GLBK_CSM_FILTER_PCF, GLBK_CSM_FILTER_ROULETTE, GLBK_CSM_FILTER_COUNT
} glbk_csm_filter;

/* Answers in bulk, as cohsm_visible_scene gives them. */
typedef struct glbk_csm_questions {
    glbk_csm_ask    ask;
    glbk_csm_filter filter;
    float           bias;       /* map pixels */
    uint32_t        seed;       /* of roulette */
    const uint32_t *items;      /* 8 words each: point as 3 floats, instance or GLBK_CSM_NO_SELF; light as 3 floats (or
                                   a cell), number for roulette */
    uint32_t        count;      /* 1 .. 2^20 */
} glbk_csm_questions;

#define GLBK_CSM_MAX_PROGRAMS 64u       /* combinations of ask, filter, kind of maps (and shape) that are kept
                                           compiled; then the one that was not used for longest makes room */

typedef struct glbk_csm_programs {
    glbk_program list[GLBK_CSM_MAX_PROGRAMS];
    uint32_t     keys[GLBK_CSM_MAX_PROGRAMS], count;
    uint32_t     used[GLBK_CSM_MAX_PROGRAMS], frame;    /* private: in which frame each was asked for last */
} glbk_csm_programs;

typedef struct glbk_csm_asker { /* read only; zeroed = none */
    glbk_csm_programs programs;
    uint32_t     question;      /* 1 + 3 ask + filter of those uploaded; 0: none */
    glbk_texture questions, answers;
    glbk_target  target;
    glbk_buffer  frame, asked, answered;    /* the latter two: compute path */
    uint32_t     capacity;
} glbk_csm_asker;

GLBK_DEF glbk_result glbk_csm_asker_create(glbk_context *ctx, uint32_t capacity, glbk_csm_asker *out);
GLBK_DEF glbk_result glbk_csm_ask_upload(glbk_context *ctx, glbk_csm_asker *asker, const glbk_csm_questions *questions);
GLBK_DEF glbk_result glbk_csm_ask_run(glbk_context *ctx, glbk_csm_asker *asker, const glbk_csm_maps *maps,
                                      uint32_t count);
GLBK_DEF glbk_result glbk_csm_ask_read(glbk_context *ctx, glbk_csm_asker *asker, uint32_t count, float *visible);
GLBK_DEF void glbk_csm_asker_destroy(glbk_context *ctx, glbk_csm_asker *asker);
/* upload    puts the questions on the GPU
   run       answers the first count of them; may be repeated. Compiles a program for the first maps with their defines,
             ask and filter. Errors: GLBK_ERR_ARGUMENT without an upload, those of glbk_program_create
   read      waits and copies count floats: 1 lit, 0 dark, between with PCF, -1 refused
   Where ctx->compute, the compute path is taken, unless storage buffers may not be as large as 32 bytes a question. */

/* ---- csm: lights ---- */

typedef enum glbk_csm_shape {   /* cohsm_shape but CALLBACK, 9, which is refused */
    GLBK_CSM_SHAPE_DEFAULT,     /* = GLBK_CSM_SHAPE_ENVIRONMENT */
    GLBK_CSM_SHAPE_ENVIRONMENT, GLBK_CSM_SHAPE_SUN, GLBK_CSM_SHAPE_POINT, GLBK_CSM_SHAPE_SPOT, GLBK_CSM_SHAPE_LINE,
    GLBK_CSM_SHAPE_RECTANGLE, GLBK_CSM_SHAPE_DISC, GLBK_CSM_SHAPE_SPHERE, GLBK_CSM_SHAPE_MESH = 10,
    GLBK_CSM_SHAPE_COUNT
} glbk_csm_shape;

typedef struct glbk_csm_light_desc {    /* fields as in cohsm_emitter_desc; time and video: update the light */
    glbk_csm_shape shape;
    float          position[3], direction[3], u[3], v[3];
    float          radius;
    float          cone_angle;          /* spot: full apex angle, radians, 1e-6..2 pi, where csm.h ends at pi */
    float          radiance[3];
    float          cosine_power, rotation;
    const float   *texels;              /* L: rgb factors, width x height, or NULL = 1 */
    uint32_t       width, height;
    const float   *triangles;           /* mesh: 9 floats each, emitting to where they turn counter-clockwise */
    uint32_t       triangle_count;
} glbk_csm_light_desc;

GLBK_DEF size_t glbk_csm_light_texels(const glbk_csm_light_desc *desc);
/* Texels (of 16 bytes) that a light takes in a table; 0: the desc is refused. Needs no context. */
GLBK_DEF glbk_result glbk_csm_light_write(const glbk_csm_light_desc *desc, uint32_t *words);
/* Writes 4 words a texel. Texels of L that are not finite or negative count as 0. */

typedef struct glbk_csm_lobe { float axis[3], exponent, scale[3]; } glbk_csm_lobe;     /* cohsm_lobe */

typedef struct glbk_csm_lights_desc {
    const glbk_csm_light_desc *lights;
    uint32_t             light_count;
    const glbk_csm_lobe *lobes;         /* of all Lafortune materials, or NULL */
    uint32_t             lobe_count;
    const float         *patterns;      /* cohsm_patterns_build, or NULL = a scrambled (0, 2)-sequence */
    uint32_t             pattern_length;    /* S; then every light must be used with S samples */
} glbk_csm_lights_desc;

typedef struct glbk_csm_lights {        /* read only; zeroed = none */
    glbk_texture texels;
    uint32_t     lobe_count, patterns_at, pattern_length;
} glbk_csm_lights;

GLBK_DEF glbk_result glbk_csm_lights_create(glbk_context *ctx, const glbk_csm_lights_desc *desc, uint32_t *starts,
                                            glbk_csm_lights *out);
/* starts   receives for each light where it begins
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_LIMIT, GLBK_ERR_ALLOC (all texels are put together in memory once) */
GLBK_DEF glbk_result glbk_csm_lights_update(glbk_context *ctx, glbk_csm_lights *lights, uint32_t start,
                                            const glbk_csm_light_desc *desc);
/* A light that moved or changed, whose glbk_csm_light_texels stayed the same. */
GLBK_DEF void glbk_csm_lights_destroy(glbk_context *ctx, glbk_csm_lights *lights);

/* ---- csm: the Monte Carlo renderer of direct light ----

   Once glbk_csm_maps_create, glbk_csm_lights_create, glbk_csm_renderer_create. A frame:

       glbk_csm_maps_place(gl, &maps, instances, n);              // where something moved, and then:
       glbk_csm_reset(&r);                                        // frames are averaged until here; camera, lights, too
       glbk_csm_gbuffer_begin(gl, &r);                            // or glbk_csm_gbuffer_upload, or your own, as below
       glbk_csm_gbuffer_object(gl, &r, &draw);                    // of each object, and your draw
       glbk_csm_render(gl, &r, &frame);
       glbk_csm_resolve(gl, &r, &pass);

   A G-buffer of your own is read by glbk_csm_renderer_desc.fragment, which makes a point of it and adds to the sum:

       layout(location = 0) out glbk_color result;
       uniform sampler2D glbk_user0;                              // up to glbk_user3
       void main()
       {
           ivec2 at = ivec2(gl_FragCoord.xy);
           vec4 sum = glbk_csm_frame.query.w > 0.0 ? glbk_unpack(texelFetch(glbk_csm_sum, at, 0)) : vec4(0.0);
           cohsm_material m;        // uint type (COHSM_BRDF_LAMBERT, _PHONG, _LAFORTUNE, _METAL_ROUGH); vec3 diffuse,
                                    // specular; float exponent, metallic, roughness; uint lobe, lobe_count
           csm_point p;             // vec3 position, normal, geometric, tangent (0 = any; all world, unit);
                                    // cohsm_material material; uint self (instance or COHSM_NO_SELF), plane (0 = none)
           ...                      // fill both; where nothing is seen leave the sum as it is
           sum += csm_shade(p, uint(at.y) * glbk_csm_frame.tables.z + uint(at.x));    // rgb radiance; a refused samples
           result = glbk_pack(sum);
       } */

typedef enum glbk_csm_brdf {    /* cohsm_brdf */
    GLBK_CSM_BRDF_NONE,         /* nothing is seen here */
    GLBK_CSM_BRDF_LAMBERT, GLBK_CSM_BRDF_PHONG, GLBK_CSM_BRDF_LAFORTUNE, GLBK_CSM_BRDF_METAL_ROUGH
} glbk_csm_brdf;

typedef enum glbk_csm_sampling { /* cohsm_sampling */
    GLBK_CSM_SAMPLING_BOTH, GLBK_CSM_SAMPLING_LIGHT, GLBK_CSM_SAMPLING_BRDF, GLBK_CSM_SAMPLING_PAPER,
    GLBK_CSM_SAMPLING_COUNT
} glbk_csm_sampling;

typedef struct glbk_csm_renderer_desc {
    uint32_t    width, height;
    uint32_t    lobes;          /* most lobes of a material: 1..8; 0 = 1 */
    int         patterns;       /* not 0: the lights have patterns */
    const char *fragment;       /* NULL; or, kept by you, your own fragment shader, with all of csm_shade before it, as
                                   shown above. Its samplers are called glbk_user0 to glbk_user3 and yours to bind
                                   before glbk_csm_render, to GLBK_SLOT_glbk_user0 .. + 3. Takes the core path */
} glbk_csm_renderer_desc;

typedef struct glbk_csm_renderer {      /* read only; zeroed = none */
    glbk_csm_programs shade;
    glbk_program fill, resolve;
    const char  *fragment;
    uint32_t     lobes, patterns;
    glbk_texture gbuffer[4], depth, sums[2];
    glbk_target  gbuffer_target, targets[2];
    glbk_buffer  frame, object;
    uint32_t     width, height, frames, passes, now;
    int          compute;
} glbk_csm_renderer;

GLBK_DEF glbk_result glbk_csm_renderer_create(glbk_context *ctx, const glbk_csm_renderer_desc *desc,
                                              glbk_csm_renderer *out);
GLBK_DEF void glbk_csm_renderer_destroy(glbk_context *ctx, glbk_csm_renderer *renderer);

typedef struct glbk_csm_surface {       /* a material, and where it is */
    glbk_csm_brdf brdf;
    float         diffuse[3];
    float         specular[3], exponent;        /* Phong */
    float         metallic, roughness;          /* metal-rough */
    uint32_t      lobe, lobe_count;             /* Lafortune: the first in glbk_csm_lights_desc.lobes */
    uint32_t      self;                         /* instance, or GLBK_CSM_NO_SELF */
    uint32_t      plane;                        /* 1 + the receiver plane that it lies on, or 0 */
} glbk_csm_surface;

typedef struct glbk_csm_pixel {
    glbk_csm_surface surface;
    float position[3], normal[3], geometric[3], tangent[3];     /* world; tangent zero = any */
} glbk_csm_pixel;

GLBK_DEF glbk_result glbk_csm_gbuffer_upload(glbk_context *ctx, glbk_csm_renderer *renderer, uint32_t row,
                                             uint32_t rows, const glbk_csm_pixel *pixels);
/* Whole rows from the CPU. Row 0 comes back first from glbk_csm_read; for a picture on the screen it is the lowest. */

typedef struct glbk_csm_draw {          /* an object drawn into the G-buffer */
    float world[16], clip[16];          /* object to world; world to clip space */
    float eye[3];
    glbk_csm_surface surface;
    const glbk_texture *diffuse_map, *specular_map, *normal_map;        /* or NULL. Factors of diffuse; of specular, or
                                           glTF's metallic in b and roughness in g; tangent space, needs tangents */
} glbk_csm_draw;

GLBK_DEF glbk_result glbk_csm_gbuffer_begin(glbk_context *ctx, glbk_csm_renderer *renderer);
/* Clears the G-buffer and binds it with its program. */
GLBK_DEF glbk_result glbk_csm_gbuffer_object(glbk_context *ctx, glbk_csm_renderer *renderer, const glbk_csm_draw *draw);
/* Then draw: attributes 0 position, 1 normal, 2 texture coordinates, 3 tangent (w: handedness) from your vertex array.
   Attributes that are not enabled must have been set to zero. */

typedef struct glbk_csm_use {           /* a light in a frame */
    uint32_t             start;         /* from glbk_csm_lights_create */
    glbk_csm_shape       shape;         /* of that light */
    const glbk_csm_maps *maps;          /* what its samples ask */
    glbk_csm_ask         ask;
    uint32_t             samples;       /* S, 1..65536 */
    uint32_t             seed;          /* another for each light */
} glbk_csm_use;

typedef struct glbk_csm_frame_desc {
    const glbk_csm_lights *lights;
    const glbk_csm_use    *uses;
    uint32_t               use_count;
    float                  eye[3];
    float                  planes[GLBK_CSM_MAX_PLANES][4];  /* receivers without maps: unit normal, distance */
    uint32_t               plane_count;
    glbk_csm_sampling      sampling;
    glbk_csm_filter        filter;
    float                  bias;                /* map pixels */
    float                  offset;              /* map pixels that receivers move, local lights; else see instances */
    uint32_t               number;              /* of the frame: other random numbers */
    uint32_t               samples_per_pass;    /* 0 = 64: a pass must not take longer than the driver's patience */
} glbk_csm_frame_desc;

GLBK_DEF glbk_result glbk_csm_render(glbk_context *ctx, glbk_csm_renderer *renderer, const glbk_csm_frame_desc *desc);
/* Adds one frame to the sum. The first use of a combination of shape, ask, filter and kind of maps compiles a program;
   see glbk_csm_prepare. After an error some lights of the frame may be in the sum: glbk_csm_reset.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_LIMIT: more than GLBK_CSM_MAX_PROGRAMS combinations in one frame; those of
            glbk_program_create and glbk_buffer_update */

GLBK_DEF glbk_result glbk_csm_prepare(glbk_context *ctx, glbk_csm_renderer *renderer, const glbk_csm_frame_desc *desc);
/* Compiles what such a frame needs, so that the first one does not stutter. Errors: as glbk_csm_render */

GLBK_DEF void glbk_csm_reset(glbk_csm_renderer *renderer);
/* Forgets all frames. */

GLBK_DEF glbk_result glbk_csm_resolve(glbk_context *ctx, glbk_csm_renderer *renderer, const glbk_pass *pass);
/* Draws the mean of the frames, linear radiance, to the pass's target; viewports: see glbk_pass. */

GLBK_DEF glbk_result glbk_csm_read(glbk_context *ctx, glbk_csm_renderer *renderer, float *rgba);
/* The mean: 4 floats a pixel; a is the mean number of samples that were refused. Waits for the GPU. */

/* ---- csm: building on the GPU ----

   Draws the layers of a builder's views by depth peeling and finds their segments (equation 1). csm.h then writes the
   block: its cohsm_builder is given, for each view, layers that keep exactly the segments found here, so that the bytes
   are those which it would have built from the layers that were drawn. For views 0 .. view_count - 1, batch by batch:

       while (from < views) { glbk_csm_builder_draw(gl, &b, from, n); glbk_csm_builder_compress(gl, &b); from += n; }
       glbk_csm_builder_replay(gl, &b, add, user);              // calls cohsm_builder_add for all views

   glbk_csm_builder_layers reads what was drawn instead, for a builder that compresses on the CPU. */

typedef enum glbk_csm_layers {  /* cohsm_layers; Z1Z3_SPHERE is built on the CPU only */
    GLBK_CSM_LAYERS_DEFAULT,    /* = GLBK_CSM_LAYERS_Z1Z2 */
    GLBK_CSM_LAYERS_Z1Z2,
    GLBK_CSM_LAYERS_Z1Z3_FAR = 3
} glbk_csm_layers;

typedef struct glbk_csm_view { float matrix[16], depth_scale; } glbk_csm_view;      /* the fields of cohsm_view */

typedef struct glbk_csm_builder_desc {
    uint32_t        map_size;           /* M, 4..1024 */
    glbk_csm_layers layers;
    uint32_t        depth_bits;         /* as in cohsm_desc; 0 = 8 */
    float           open_thickness;     /* as in cohsm_desc; 0 = 8 */
    int             positional, self_only;
    void          (*view_fn)(void *user, uint32_t index, glbk_csm_view *out);   /* cohsm_builder_view */
    void          (*draw_fn)(void *user, glbk_context *ctx);    /* your object: bind its vertex array, attribute 0 the
                                           position in object space, and draw; program and state are ours */
    void           *user;
} glbk_csm_builder_desc;

typedef struct glbk_csm_segment { uint32_t first, pixel, value; } glbk_csm_segment; /* private */

typedef struct glbk_csm_builder {       /* batch: most views that are drawn at once. The rest is private */
    uint32_t              batch, tiles, drawn, drawn_from, next_view, passes;
    glbk_csm_builder_desc desc;
    glbk_program          first_layer, next_layer, compress;
    glbk_texture          layers[3], depth, opened[2], records[3];
    glbk_target           layer_targets[3], targets[2];
    glbk_buffer           block, storage;
    int                   now, compute;
    uint32_t             *words;        /* what was read back */
    uint32_t             *firsts;       /* of the open segment of each pixel */
    glbk_csm_segment     *segments;
    size_t                segment_count, segment_room;
} glbk_csm_builder;

GLBK_DEF glbk_result glbk_csm_builder_create(glbk_context *ctx, const glbk_csm_builder_desc *desc,
                                             glbk_csm_builder *out);
GLBK_DEF glbk_result glbk_csm_builder_draw(glbk_context *ctx, glbk_csm_builder *builder, uint32_t from, uint32_t count);
GLBK_DEF glbk_result glbk_csm_builder_layers(glbk_context *ctx, glbk_csm_builder *builder, uint32_t view,
                                             uint32_t layer, float *depths);
GLBK_DEF glbk_result glbk_csm_builder_compress(glbk_context *ctx, glbk_csm_builder *builder);
GLBK_DEF glbk_result glbk_csm_builder_replay(glbk_context *ctx, glbk_csm_builder *builder,
                                             int (*add_fn)(void *user, uint32_t index, const float *z1, const float *z2,
                                                           const float *z3), void *user);
GLBK_DEF void glbk_csm_builder_destroy(glbk_context *ctx, glbk_csm_builder *builder);
/* draw      count <= builder->batch views from view `from` on
   layers    layer 0, 1 (2 with Z1Z3) of a view from the last draw: map_size^2 depths, above 1 where there is no hit
   compress  the views drawn last, which must follow those compressed before
   replay    after the last view: add_fn(user, index, z1, z2, z3) for each in turn; its not 0 ends with
             GLBK_ERR_ARGUMENT. Stored segments are those of the layers; cohsm_stats of it counts no open, empty entries
   Memory    16 map_size^2 words, 12 bytes a segment (twice in replay)
   Errors    GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC */

/* ---- sfield: shadow fields, after shadowfield.h ----

   Fields of spherical harmonics are uploaded as sfield_write wrote them, all of a scene into one table with what the
   product needs; the entities of the frame and the sky are in another, so that moving them leaves fields alone. A pixel
   of the G-buffer is any point to shade: one of the screen, or a vertex. Wavelets and fields of logarithms are
   shadowfield.h's alone. A frame: glbk_sfield_place (and _sky), the G-buffer, glbk_sfield_shade; renderer.light has the
   picture. For shaders of your own, lib/sfield_shade.glsl with glbk_sfield_bind, SFIELD_BANDS defined:

       void sfield_cosine(vec3 n, out float t[SFIELD_COEFS]);
       sfield_sums sfield_shade(vec3 position, vec3 normal, uint own, float t[SFIELD_COEFS], float g[SFIELD_COEFS]);

   World space, normals unit; own: the entity that the point lies on, or SFIELD_NONE; t: of sfield_cosine, or own
   visibility x cosine, turned into the world; g: t times Phong's lobe, read with SFIELD_GLOSS=1 alone. Result: light
   (rgb irradiance, W/m^2; times albedo / pi it is radiance), gloss, open (first coefficient of what stays visible). */

#define GLBK_SFIELD_TEXTURES(X)                                                                     \
    X(usampler2DArray, glbk_sfield_table, 0)    /* terms, fields */                                 \
    X(usampler2D, glbk_sfield_place, 1)         /* G-buffer */                                      \
    X(usampler2D, glbk_sfield_normal, 2)                                                            \
    X(usampler2DArray, glbk_sfield_self, 3)                                                         \
    X(usampler2D, glbk_sfield_seen, 4)          /* building: samples; texels; integrals of the basis */ \
    X(usampler2D, glbk_sfield_cube, 5)                                                              \
    X(usampler2DArray, glbk_sfield_basis, 6)                                                        \
    X(usampler2DArray, glbk_sfield_moving, 7)   /* sky, entities, rotations */

#define GLBK_SFIELD_SCENE_MEMBERS(X)                                                                \
    X(uvec4, table, 1)          /* texel of the entities, count, lights; 1: go to the sky */        \
    X(uvec4, parts, 1)          /* texel of the terms, pairs of them; texel of the sky */

#define GLBK_SFIELD_FRAME_MEMBERS(X) X(vec4, eye, 1)

#define GLBK_SFIELD_OBJECT_MEMBERS(X)                                                               \
    X(mat4, world, 1)                                                                               \
    X(mat4, clip, 1)                                                                                \
    X(uvec4, kinds, 1)          /* entity; 1: own visibility is given */                            \
    X(vec4, gloss, 1)           /* exponent */

#define GLBK_SFIELD_VIEWS_MEMBERS(X)                                                                \
    X(vec4, sphere, 1)          /* centre, radius */                                                \
    X(uvec4, how, 1)            /* first tile, tiles a column, samples a side of a tile, N */       \
    X(uvec4, size, 1)           /* eyes a batch, groups of four coefficients */                     \
    X(vec4, eyes, 256)          /* of each tile: in radii about the centre; 1 / greatest depth */   \
    X(uvec4, places, 256)       /* face, eye; column, row of the atlas */

#define GLBK_SFIELD_BLOCKS(X)                                                                       \
    X(glbk_sfield_scene, 0, GLBK_SFIELD_SCENE_MEMBERS)                                              \
    X(glbk_sfield_frame, 1, GLBK_SFIELD_FRAME_MEMBERS)                                              \
    X(glbk_sfield_object, 2, GLBK_SFIELD_OBJECT_MEMBERS)                                            \
    X(glbk_sfield_views, 3, GLBK_SFIELD_VIEWS_MEMBERS)

#define GLBK_SFIELD_STORAGE(X)
#define GLBK_SFIELD_IMAGES(X)                                                                       \
    X(writeonly, rgba32f, image2D, glbk_sfield_light_image, 0)                                      \
    X(writeonly, rgba32f, image2D, glbk_sfield_gloss_image, 1)                                      \
    X(writeonly, rgba32ui, uimage2D, glbk_sfield_cube_image, 2) /* building */                      \
    X(writeonly, rgba32ui, uimage2D, glbk_sfield_coefs_image, 3)

GLBK__PART(SFIELD)

#define GLBK_SFIELD_NONE 0xffffffffu

typedef struct glbk_sfield_file { const void *data; size_t size; } glbk_sfield_file;    /* from sfield_write */

typedef struct glbk_sfield_field {      /* read only: a field in a scene */
    uint32_t start;                     /* its first texel */
    int      source;
    float    center[3], radius, inscribed, outer;       /* in its own space; outer in radii */
} glbk_sfield_field;

typedef struct glbk_sfield_desc {
    uint32_t                bands;      /* 1..8, that of all files */
    const glbk_sfield_file *files;      /* occlusion and source fields; kept by you until the call returns */
    uint32_t                file_count;
    const uint32_t         *terms;      /* tripling coefficients, from sfield_sh_terms: i | j << 8 | k << 16 */
    const float            *factors;
    uint32_t                term_count; /* none with 1 band */
    uint32_t                capacity;   /* most entities, 1..65535 */
    float                   reach;      /* occluders count up to this many radii; 0 = the outermost shell of each */
} glbk_sfield_desc;

typedef struct glbk_sfield_world {      /* read only; zeroed = none */
    glbk_texture table;
    glbk_buffer  scene;
    uint32_t     bands, capacity, count, lights, terms, texels, entities_at;    /* texels: of the table */
    int          sky;
    float        reach;
    glbk_texture moving;                /* sky, entities, rotations */
} glbk_sfield_world;

GLBK_DEF glbk_result glbk_sfield_create(glbk_context *ctx, const glbk_sfield_desc *desc, glbk_sfield_field *fields,
                                        glbk_sfield_world *out);
/* Uploads fields; room for file_count in `fields`, to name them by.
   Errors   GLBK_ERR_ARGUMENT: not a file of spherical harmonics of these bands, or damaged (the checksum is not looked
            at); GLBK_ERR_LIMIT, GLBK_ERR_ALLOC
   Memory   on the GPU the files, with coefficients filled up to a multiple of 16; 16 KB here, while it runs */
GLBK_DEF void glbk_sfield_destroy(glbk_context *ctx, glbk_sfield_world *world);

typedef struct glbk_sfield_entity {
    const glbk_sfield_field *occlusion, *source;        /* or NULL */
    float        transform[16];         /* field space to world: rotation, one scale > 0, translation */
    float        tint[3], time;         /* of the source */
    const float *rotation;              /* sfield_rotation.block of the transform; NULL = it does not turn */
} glbk_sfield_entity;

GLBK_DEF glbk_result glbk_sfield_place(glbk_context *ctx, glbk_sfield_world *world, const glbk_sfield_entity *entities,
                                       uint32_t count);
/* Where everything is now. Errors GLBK_ERR_ARGUMENT (a transform, or it turns without rotation), GLBK_ERR_ALLOC: some
   of them may be placed already then. */
GLBK_DEF glbk_result glbk_sfield_sky(glbk_context *ctx, glbk_sfield_world *world, const float *coefs);
/* Environment and suns: 3 bands^2 coefficients from sfield_scene_sky; NULL = none. */
GLBK_DEF void glbk_sfield_bind(glbk_context *ctx, const glbk_sfield_world *world);
/* For your own program with sfield_shade.glsl: compile it with SFIELD_BANDS=bands. */

typedef struct glbk_sfield_renderer_desc {
    uint32_t        width, height, bands;
    int             gloss;              /* not 0: Phong lobes too */
    const uint32_t *terms;              /* as in glbk_sfield_desc: written into the program, several times as fast; or
                                           NULL: */
    const float    *factors;            /* read from the table, as is done from 5 bands on anyway */
    uint32_t        term_count;
} glbk_sfield_renderer_desc;

typedef struct glbk_sfield_renderer {   /* read only; zeroed = none */
    glbk_texture light, gloss;          /* GLBK_FORMAT_COLOR. light: rgb to multiply by albedo, a: the open share of the
                                           cosine-weighted sphere. gloss: rgb to multiply by the specular colour */
    glbk_texture place, normal, self, depth;
    glbk_target  target, gbuffer_target;
    glbk_program shade, fill;
    glbk_buffer  frame, object;
    uint32_t     width, height, bands;
    int          compute;
} glbk_sfield_renderer;

GLBK_DEF size_t glbk_sfield_write_product(uint32_t bands, const uint32_t *terms, const float *factors, uint32_t count,
                                          char *out, size_t size);
/* sfield_product with its numbers in it, for a program that defines SFIELD_UNROLLED: its text goes after "sfield_access
   sfield_field" and before lib/sfield_shade.glsl. Returns the bytes needed with the 0; out may be NULL with size 0. */

GLBK_DEF glbk_result glbk_sfield_renderer_create(glbk_context *ctx, const glbk_sfield_renderer_desc *desc,
                                                 glbk_sfield_renderer *out);
GLBK_DEF void glbk_sfield_renderer_destroy(glbk_context *ctx, glbk_sfield_renderer *renderer);

typedef struct glbk_sfield_pixel {      /* a point to shade */
    float        position[3], normal[3];        /* world; normal zero: nothing is seen */
    uint32_t     entity;                /* that it lies on, which neither hides nor lights it; or GLBK_SFIELD_NONE */
    const float *self;                  /* bands^2 coefficients from sfield_self, mixed as you like, in that entity's
                                           space; NULL = the cosine. Kept with 16 bits, 5e-5 */
    float        exponent;              /* Phong, 1..1000; 0 = no lobe */
} glbk_sfield_pixel;

GLBK_DEF glbk_result glbk_sfield_upload(glbk_context *ctx, glbk_sfield_renderer *renderer, uint32_t row, uint32_t rows,
                                        const glbk_sfield_pixel *pixels);
/* Whole rows of the G-buffer from the CPU. Row 0 comes back first from glbk_sfield_read. The compute path finds
   entities for 8 x 8 pixels together: points near each other belong in one such block. */

typedef struct glbk_sfield_draw {       /* an object drawn into the G-buffer */
    float    world[16], clip[16];       /* object to world, which is its entity's transform; world to clip space */
    uint32_t entity;
    int      recorded;                  /* not 0: attributes 2 to 5 hold coefficients of own visibility */
    float    exponent;
} glbk_sfield_draw;

GLBK_DEF glbk_result glbk_sfield_gbuffer_begin(glbk_context *ctx, glbk_sfield_renderer *renderer);
/* Clears the G-buffer and binds it with its program. Errors GLBK_ERR_LIMIT: more than 4 bands. */
GLBK_DEF glbk_result glbk_sfield_gbuffer_object(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                                const glbk_sfield_draw *draw);
/* Then draw: attributes 0 position, 1 normal, 2 to 5 four coefficients each, from your vertex array. */

GLBK_DEF glbk_result glbk_sfield_shade(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                       const glbk_sfield_world *world, const float eye[3], int open);
/* Direct light at all pixels into renderer->light and gloss. eye: for lobes, else NULL. open: not 0 = light.a is wanted
   even where there is no sky. Not clamped: ringing may go below 0. */
GLBK_DEF glbk_result glbk_sfield_read(glbk_context *ctx, glbk_sfield_renderer *renderer, float *light, float *gloss);
/* 4 floats a pixel each, or NULL. Waits for the GPU. */

/* ---- sfield: building on the GPU ----

   Draws what is seen from the sample points of a field, up to 256 faces of cubes at a time in one atlas, counts samples
   into texels and projects these on harmonics. shadowfield.h asks for it and makes the field:

       int see(void *user, const sfield_views *v)
       {
           return glbk_sfield_builder_see(gl, &b, v->center, v->radius, v->count, v->eyes, v->values) != GLBK_OK;
       }
       ... sfield_build_views(&desc, 0, &mesh, see, NULL, &field, NULL); */

typedef struct glbk_sfield_builder_desc {
    uint32_t        cube_side;          /* N, a power of two, 4..64, as in sfield_desc */
    uint32_t        bands;              /* 1..8; 0 = texels, for wavelets */
    const float    *basis;              /* bands^2 floats for each of the 6 N^2 texels, from sfield_cube_basis */
    int             source;             /* not 0: radiance, else alpha */
    const float    *positions;          /* the mesh, as in sfield_mesh, with its rules; NULL = draw_fn */
    size_t          vertex_count, vertex_stride;
    const uint32_t *indices;
    size_t          index_count;
    const float    *radiance;           /* sources: r, g, b of each triangle, 0..1e18; one frame, others by draw_fn */
    void          (*draw_fn)(void *user, glbk_context *ctx, int32_t instances);     /* your object, within the sphere:
                                           bind its vertex array, attribute 0 the position in the field's space,
                                           sources: attribute 1 the radiance of the triangle, and draw so many
                                           instances; program and state are ours */
    void           *user;
} glbk_sfield_builder_desc;             /* all arrays are kept by you until glbk_sfield_builder_create returns */

typedef struct glbk_sfield_builder {    /* batch: most eyes of which cubes are kept at once. The rest is private */
    uint32_t      batch, side, bands, groups, height;
    int           source;
    void        (*draw_fn)(void *user, glbk_context *ctx, int32_t instances);
    void         *user;
    float         center[3], radius;    /* of your mesh */
    uint32_t      vertex_array, index_count;
    glbk_buffer   vertices, indices, block;
    glbk_texture  seen, depth, cube, coefs, basis;
    glbk_target   seen_target, cube_target, coef_target;
    glbk_program  see, sum, project;
    glbk_sfield_views *views;
    uint32_t     *words;                /* what was read back */
    int           compute;
} glbk_sfield_builder;

GLBK_DEF glbk_result glbk_sfield_builder_create(glbk_context *ctx, const glbk_sfield_builder_desc *desc,
                                                glbk_sfield_builder *out);
GLBK_DEF glbk_result glbk_sfield_builder_see(glbk_context *ctx, glbk_sfield_builder *builder, const float center[3],
                                             float radius, size_t count, const float *eyes, float *values);
GLBK_DEF void glbk_sfield_builder_destroy(glbk_context *ctx, glbk_sfield_builder *builder);
/* see       the members of a sfield_views. values: bands^2 coefficients, or 6 N^2 texels, of each eye, for sources
             three times that. Samples as sfield_build takes them: 64 to 512 a side of a face (sources 256), by distance
   Memory    on the GPU 4 MB (sources 20), cubes of a batch, the mesh, bands^2 x 24 N^2 bytes; here what is read back of
             a batch. In glbk_sfield_builder_create once more the mesh, or the basis
   Errors    GLBK_ERR_ARGUMENT (also an index beyond vertex_count, no triangle left; `values` may be half written),
             GLBK_ERR_ALLOC, GLBK_ERR_LIMIT. No float targets are needed */

/* ---- end of sfield ---- */

/* ---- envsh: environment-map shadows, after envshadow.h ----

   k shadow maps in one atlas, drawn through your callback, then one pass that lights every pixel with all of them (the
   paper's algorithm 1), or clusters of fewer maps and several passes (algorithm 2). Lights and matrices come from
   envshadow.h (envsh_maps_create with no_depth); its numbers for filters hold here. docs/gpu-layouts.md has the
   layouts. For shaders of your own, lib/envsh_light.glsl with glbk_envsh_bind:

       vec3 envsh_light(vec3 p, vec3 n, vec3 flat_n, uint index);         // irradiance of all lights, W/m^2
       float envsh_visible(envsh_query q, uint light, vec3 p, vec3 n, uint index);    // 0..1; q: envsh_bound_query()

   World space, unit normals on the side that is seen: n for shading, flat_n (n of envsh_visible) the surface's own;
   index: another for each pixel, it turns the taps. envsh_direction(light): unit, to it; envsh_power(light): W/m^2. */

#define GLBK_ENVSH_TEXTURES(X)                                                                      \
    X(sampler2DArray, glbk_envsh_depth, 0)      /* the atlas: depth, or */                          \
    X(usampler2DArray, glbk_envsh_depth4, 1)    /* the bits of four maps' depths */                 \
    X(usampler2DArray, glbk_envsh_cells, 2)     /* least and greatest depth of cells, as bits */    \
    X(usampler2DArray, glbk_envsh_views, 3)     /* lights */                                        \
    X(usampler2D, glbk_envsh_place, 4)          /* G-buffer */                                      \
    X(usampler2D, glbk_envsh_normal, 5)                                                             \
    X(usampler2D, glbk_envsh_flat, 6)                                                               \
    X(usampler2D, glbk_envsh_color, 7)                                                              \
    X(glbk_color_sampler, glbk_envsh_sum, 8)                                                        \
    X(sampler2D, glbk_envsh_color_map, 9)

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
    X(mat4, clip, 1)                                                                                \
    X(vec4, color, 1)                                                                               \
    X(vec4, eye, 1)             /* w: texels of less alpha are holes */                             \
    X(uvec4, lights, 1)         /* casting: first light, step; G-buffer: z, map; cells: job; resolving: corner, lit */

#define GLBK_ENVSH_BLOCKS(X)                                \
    X(glbk_envsh_scene, 0, GLBK_ENVSH_SCENE_MEMBERS)        \
    X(glbk_envsh_query, 1, GLBK_ENVSH_QUERY_MEMBERS)        \
    X(glbk_envsh_object, 2, GLBK_ENVSH_OBJECT_MEMBERS)

#define GLBK_ENVSH_STORAGE(X)
#define GLBK_ENVSH_IMAGES(X)    X(restrict, rgba32f, image2D, glbk_envsh_total, 0)   /* the sum, by compute */

GLBK__PART(ENVSH)

#define GLBK_ENVSH_MAX_LIGHTS 8192u     /* ENVSH_MAX_LIGHTS */
#define GLBK_ENVSH_MAX_TAPS 64u

typedef struct glbk_envsh_maps_desc {
    uint32_t    capacity;       /* lights held at once, 1..8192: all k, or a cluster of c */
    uint32_t    map_size;       /* texels a side of a tile, as in envsh_maps_desc, 16..4096; 0 = 256 */
    uint32_t    guard;          /* as there, 1..map_size / 4; 0 = 4 */
    int         rgba;           /* not 0: four maps share a texel: a quarter of the pages, four rounds of drawing */
    const char *vertex;         /* both NULL; or your own shaders for what casts shadows (skinning, alpha masks), */
    const char *fragment;       /* made as lib/envsh_cast.glsl says */
} glbk_envsh_maps_desc;         /* zero it, then set what you care about */

typedef struct glbk_envsh_maps {        /* read only; zeroed = none */
    glbk_program cast, make_cells;
    glbk_texture atlas, depth, cells, views;    /* depth: with rgba only */
    glbk_target  atlas_target, cell_target;
    glbk_buffer  scene, query, object;
    uint32_t     map_size, guard, channels, capacity, count;
    uint32_t     across, down, pages, cells_wide, levels;
    uint32_t     first, step;           /* while casting: the instances' lights */
} glbk_envsh_maps;

GLBK_DEF glbk_result glbk_envsh_maps_create(glbk_context *ctx, const glbk_envsh_maps_desc *desc, glbk_envsh_maps *out);
/* Tiles lie as square as may be in pages of at most ctx->max_size texels a side, pages are layers of a texture.
   Memory on the GPU: 4 bytes a texel of map_size^2 x capacity (rgba: and 4 bytes a texel of a page), an eighth for
   cells (a sixth where map_size / 8 is no power of two), 128 bytes a light.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_LIMIT where pages pass ctx->max_layers or 1024; those of programs and
   textures */
GLBK_DEF void glbk_envsh_maps_destroy(glbk_context *ctx, glbk_envsh_maps *maps);

typedef glbk_result (*glbk_envsh_draw)(void *user, glbk_context *ctx, glbk_envsh_maps *maps, uint32_t instances);
/* Draws everything that casts shadows, each object by one call: glbk_envsh_cast, your vertex array (attribute 0 is the
   position), then an instanced draw with that many instances. What it returns ends the pass where it is not GLBK_OK.
   It is called once for each page, with rgba once for each channel of it, on ES once for each column of tiles. */

GLBK_DEF glbk_result glbk_envsh_cast(glbk_context *ctx, glbk_envsh_maps *maps, const float world[16]);
/* Inside glbk_envsh_draw: the matrix of the next object; NULL = identity. */

GLBK_DEF glbk_result glbk_envsh_maps_render(glbk_context *ctx, glbk_envsh_maps *maps, const void *views,
                                            size_t view_size, uint32_t count, glbk_envsh_draw draw, void *user);
/* The shadow maps of a frame.
   views      count of envshadow.h's envsh_view (envsh_maps_views), at most the capacity; where their tiles lie is not
              looked at. Made with the map_size and guard of desc
   view_size  sizeof(envsh_view)
   Errors     GLBK_ERR_ARGUMENT (another size, too), what draw returned */

typedef enum glbk_envsh_filter {        /* envsh_filter */
    GLBK_ENVSH_FILTER_PLAIN, GLBK_ENVSH_FILTER_SMOOTH, GLBK_ENVSH_FILTER_PCF, GLBK_ENVSH_FILTER_PENUMBRA,
    GLBK_ENVSH_FILTER_COUNT
} glbk_envsh_filter;

typedef struct glbk_envsh_question {    /* as in envsh_query, no defaults */
    glbk_envsh_filter filter;
    uint32_t taps, seed;
    float    radius, bias, extent_scale;
} glbk_envsh_question;

GLBK_DEF glbk_result glbk_envsh_bind(glbk_context *ctx, glbk_envsh_maps *maps, const glbk_envsh_question *question);
/* For a program of yours with envsh_light among its library files and ENVSH_FILTER=filter and ENVSH_RGBA=0 or 1 among
   its defines, which is bound: textures and uniform blocks. Errors: GLBK_ERR_ARGUMENT, a field out of range */

/* ---- envsh: complete passes ----

   Once glbk_envsh_maps_create and glbk_envsh_renderer_create. A frame:

       envsh_maps_begin(layout, lights, n, bounds);                       // envshadow.h: matrices of the views
       glbk_envsh_gbuffer_begin(gl, &r);                                  // or glbk_envsh_gbuffer_upload
       glbk_envsh_gbuffer_object(gl, &r, &surface);                       // of each object, and your draw
       glbk_envsh_illuminate(gl, &r, &maps, views, sizeof *views, n, draw, user, &question);
       glbk_envsh_resolve(gl, &r, &pass);

   glbk_envsh_maps_render and glbk_envsh_shade are the two halves of glbk_envsh_illuminate. Where ctx->compute, the
   compute path is taken. */

typedef struct glbk_envsh_renderer {    /* read only; zeroed = none */
    glbk_program shade[2 * GLBK_ENVSH_FILTER_COUNT], fill, resolve;
    glbk_texture gbuffer[4], depth, sums[2];
    glbk_target  gbuffer_target, targets[2];
    glbk_buffer  object;
    uint32_t     width, height, now;
    int          begun;                 /* the sum holds light */
    int          compute;               /* one sum, changed in place */
} glbk_envsh_renderer;

GLBK_DEF glbk_result glbk_envsh_renderer_create(glbk_context *ctx, uint32_t width, uint32_t height,
                                                glbk_envsh_renderer *out);
GLBK_DEF void glbk_envsh_renderer_destroy(glbk_context *ctx, glbk_envsh_renderer *renderer);

typedef struct glbk_envsh_pixel {
    float position[3], normal[3], geometric[3], albedo[3];      /* world; unit, on the side that is seen */
    int   seen;                         /* 0: nothing is there */
} glbk_envsh_pixel;

GLBK_DEF glbk_result glbk_envsh_gbuffer_upload(glbk_context *ctx, glbk_envsh_renderer *renderer, uint32_t row,
                                               uint32_t rows, const glbk_envsh_pixel *pixels);
/* Whole rows from the CPU. Row 0 comes back first from glbk_envsh_read; for a picture on the screen it is the
   lowest. */

typedef struct glbk_envsh_surface {     /* an object drawn into the G-buffer */
    float world[16], clip[16];          /* object to world; world to clip space */
    float eye[3];
    float albedo[4];
    float alpha_cutoff;                 /* texels of less alpha are holes; 0 = none */
    const glbk_texture *color_map;      /* factors of albedo, or NULL */
} glbk_envsh_surface;

GLBK_DEF glbk_result glbk_envsh_gbuffer_begin(glbk_context *ctx, glbk_envsh_renderer *renderer);
/* Clears the G-buffer and binds it with its program. */
GLBK_DEF glbk_result glbk_envsh_gbuffer_object(glbk_context *ctx, glbk_envsh_renderer *renderer,
                                               const glbk_envsh_surface *surface);
/* Then draw: attributes 0 position, 1 normal, 2 texture coordinates. Those not enabled must have been set to zero. */

GLBK_DEF glbk_result glbk_envsh_shade(glbk_context *ctx, glbk_envsh_renderer *renderer, glbk_envsh_maps *maps,
                                      const glbk_envsh_question *question, uint32_t lights_per_pass, int add);
/* Light of all maps that were rendered, to the sum of each pixel.
   lights_per_pass  0 = all in one pass, as the paper has it; fewer where a driver's patience is short
   add              not 0: to the sum as it is. The first use of a filter compiles a program */

GLBK_DEF glbk_result glbk_envsh_illuminate(glbk_context *ctx, glbk_envsh_renderer *renderer, glbk_envsh_maps *maps,
                                           const void *views, size_t view_size, uint32_t count, glbk_envsh_draw draw,
                                           void *user, const glbk_envsh_question *question);
/* The paper's algorithm 2 in clusters of the maps' capacity, or 1 where that holds all count lights: renders their maps
   and adds their light. views: of all lights, made by envsh_maps_create with no_depth and a capacity of count. */

GLBK_DEF glbk_result glbk_envsh_resolve(glbk_context *ctx, glbk_envsh_renderer *renderer, const glbk_pass *pass);
/* Draws irradiance x albedo / pi, linear radiance, to the pass's target; viewports: see glbk_pass. */
GLBK_DEF glbk_result glbk_envsh_read(glbk_context *ctx, glbk_envsh_renderer *renderer, float *rgba);
/* The irradiance: 4 floats a pixel, the last one 0. Waits for the GPU. */

/* ---- end of envsh ---- */

/* ---- rsm: reflective shadow maps, after rsm.h ----

   Maps come from the CPU (rsm_map_texels, as they are) or are drawn here, by calls of yours; pixel lights are picked by
   flux from running sums that are made here too. A frame:

       glbk_rsm_map_draw(gl, &r, &map, draw, user);               // or glbk_rsm_map_upload
       glbk_rsm_gbuffer_draw(gl, &r, view, eye, draw, user);      // or glbk_rsm_gbuffer_upload
       glbk_rsm_direct(gl, &r, maps, n, &direct);                 // light itself, shadowed by the same maps
       glbk_rsm_gather(gl, &r, maps, n, &gather, &grid);          // bounced light; grid NULL: every pixel
       glbk_rsm_denoise(gl, &r, &denoise);                        // where few samples were taken
       glbk_rsm_resolve(gl, &r, &pass, 1, 1);

   All images are RGBA32UI, bits of floats, so that everything works without EXT_color_buffer_float. Enumerations have
   rsm.h's numbers. For shaders of your own, lib/rsm_direct.glsl and lib/rsm_gather.glsl with glbk_rsm_bind:

       rsm_lamp rsm_bound();                                              // the light whose map is bound
       vec3 rsm_direct(rsm_lamp l, vec3 p, vec3 n, int taps, float bias, float slope_bias);   // irradiance, W/m^2
       vec3 rsm_gather_list(rsm_lamp l, vec3 p, vec3 n, uint from, uint to, bool glossy, float mixed);
       vec3 rsm_gather_about(rsm_lamp l, vec3 p, vec3 n, float r_max, vec2 turn, uint first, uint step, uint count,
                             vec4 limits, bool glossy, float mixed, float picked, float near_field);

   World space, unit normals. The latter two give pi times bounced irradiance: by lights from .. to - 1 of the list
   (glbk_rsm_frame.range.x and .y; glossy glbk_rsm_frame.pick.w != 0u; mixed glbk_rsm_frame.pattern.y), and by points
   first, first + step, ... of the tables about p (turn: cosine and sine; limits glbk_rsm_frame.limits; picked
   glbk_rsm_frame.pattern.z). */

#define GLBK_RSM_TEXTURES(X)                                                                        \
    X(usampler2DArray, glbk_rsm_texels, 0)      /* a map: layers 3 face + 0 place, 1 normal, 2 flux */ \
    X(usampler2DArray, glbk_rsm_sums, 1)                                                            \
    X(usampler2DArray, glbk_rsm_rows, 2)                                                            \
    X(usampler2DArray, glbk_rsm_lights, 3)      /* the list of pixel lights */                      \
    X(sampler2D, glbk_rsm_pattern, 4)                                                               \
    X(sampler2D, glbk_rsm_noise, 5)                                                                 \
    X(sampler2D, glbk_rsm_materials, 6)                                                             \
    X(usampler2DArray, glbk_rsm_seen, 7)        /* G-buffer: place, normal, colour */               \
    X(usampler2DArray, glbk_rsm_before, 8)      /* that of the last frame */                        \
    X(glbk_color_sampler, glbk_rsm_sum, 9)                                                          \
    X(glbk_color_sampler, glbk_rsm_states, 10)  /* the picture while it is interpolated */          \
    X(glbk_color_sampler, glbk_rsm_coarse, 11)  /* a grid of samples */                             \
    X(glbk_color_sampler, glbk_rsm_history, 12)                                                     \
    X(sampler2D, glbk_rsm_motion, 13)                                                               \
    X(sampler2D, glbk_rsm_albedo_map, 14)

#define GLBK_RSM_LIGHT_MEMBERS(X)                                                                   \
    X(vec4, position, 1)        /* w: half a side of the map (sun) or its tangent */                \
    X(vec4, right, 1)           /* w: kind */                                                       \
    X(vec4, up, 1)              /* w: faces */                                                      \
    X(vec4, axis, 1)            /* w: cosine of half the cone */                                    \
    X(vec4, value, 1)           /* w: texels a side */

#define GLBK_RSM_FRAME_MEMBERS(X)                                                                   \
    X(uvec4, counts, 1)         /* taps; interleave; points about the receiver; side of the noise */ \
    X(uvec4, range, 1)          /* of the list: from, to, room of a set; not 0: add. Resolving: corner */ \
    X(uvec4, pick, 1)           /* seed, lights of the map, first run, materials; of a scan: layer, stride */ \
    X(uvec4, grid, 1)           /* step, that of the grid before (compute: the finest), width, height */ \
    X(uvec4, mode, 1)                                                                               \
    X(vec4, pattern, 1)         /* r_max; scale and lights of MIXED; frames of the filter, reach */ \
    X(vec4, limits, 1)          /* offset, clamp, near_limit, sets; direct: bias, slope bias */     \
    X(vec4, tests, 1)           /* normal_cosine, plane_slope, distance, contrast */            \
    X(uvec4, lists, 1)          /* of compute: read, for open pixels, for wanted nodes; step of the next grid */ \
    X(vec4, surfaces, 1)        /* near_field */

#define GLBK_RSM_DRAWN_MEMBERS(X)                                                                  \
    X(mat4, world, 1)                                                                               \
    X(mat4, clip, 1)                                                                                \
    X(vec4, albedo, 1)          /* w: cut-off of the map's alpha */                                 \
    X(vec4, eye, 1)             /* w = 0: a direction */                                            \
    X(vec4, range, 1)           /* of depth: nearest, 1 / extent */                                 \
    X(uvec4, kinds, 1)          /* material, has a map, face */

#define GLBK_RSM_BLOCKS(X)                              \
    X(glbk_rsm_light, 0, GLBK_RSM_LIGHT_MEMBERS)        \
    X(glbk_rsm_frame, 1, GLBK_RSM_FRAME_MEMBERS)        \
    X(glbk_rsm_drawn, 2, GLBK_RSM_DRAWN_MEMBERS)

#define GLBK_RSM_STORAGE(X)                                                                         \
    X(coherent, uint, glbk_rsm_counts, 0)   /* of each list 4: groups x, y, 1; pixels */            \
    X(readonly, uint, glbk_rsm_items, 1)    /* a list: x | y << 16 */                               \
    X(writeonly, uint, glbk_rsm_left, 2)                                                            \
    X(writeonly, uint, glbk_rsm_wanted, 3)                                                          \
    X(coherent, uint, glbk_rsm_marks, 4)    /* a bit a node of the finest grid */

#define GLBK_RSM_IMAGES(X)                                                                          \
    X(restrict, rgba32f, image2D, glbk_rsm_picture, 0)                                              \
    X(restrict, rgba32f, image2D, glbk_rsm_nodes, 1)    /* of the finest grid and all before it */  \
    X(restrict writeonly, r32ui, uimage2DArray, glbk_rsm_running, 2)

GLBK__PART(RSM)

typedef enum glbk_rsm_kind {    /* rsm_light_kind */
    GLBK_RSM_DEFAULT,           /* = GLBK_RSM_SUN */
    GLBK_RSM_SUN, GLBK_RSM_SPOT, GLBK_RSM_SQUARE_SPOT, GLBK_RSM_POINT, GLBK_RSM_PATCH, GLBK_RSM_KIND_COUNT
} glbk_rsm_kind;

typedef struct glbk_rsm_lamp {  /* rsm_light, field by field */
    glbk_rsm_kind kind;
    float position[3], direction[3], up[3], value[3];
    float radius, cone_angle;
    float near_depth, far_depth;
} glbk_rsm_lamp;

typedef struct glbk_rsm_map {           /* read only; zeroed = none */
    uint32_t       size, faces;         /* faces: 1, 5 or 6 */
    glbk_rsm_lamp  lamp;
    glbk_rsm_light block;
    glbk_buffer    light;
    glbk_texture   texels, depth, sums[2], rows[2];
    glbk_target    faces_drawn[6], sum_targets[2][6], row_targets[2][6];
    int            summed, sums_at, rows_at;
} glbk_rsm_map;

GLBK_DEF glbk_result glbk_rsm_map_create(glbk_context *ctx, const glbk_rsm_lamp *lamp, uint32_t size,
                                         glbk_rsm_map *out);
/* An empty map of the light. size: texels a side, 4..4096; 0 = 512, cubes 256. 60 bytes a texel.
   Errors   GLBK_ERR_ARGUMENT (what rsm_map_create refuses), GLBK_ERR_LIMIT */
GLBK_DEF glbk_result glbk_rsm_map_place(glbk_context *ctx, glbk_rsm_map *map, const glbk_rsm_lamp *lamp);
/* The light moved or changed; faces stay as many. Draw or upload anew afterwards. */
GLBK_DEF glbk_result glbk_rsm_map_upload(glbk_context *ctx, glbk_rsm_map *map, const void *texels);
/* rsm_map_texels of a map of the same light and size: faces x size x size x 48 bytes. Errors: GLBK_ERR_ALLOC */
GLBK_DEF glbk_result glbk_rsm_map_read(glbk_context *ctx, const glbk_rsm_map *map, uint32_t face, void *texels);
/* One face in that form, size x size x 48 bytes. Waits for the GPU. Errors: GLBK_ERR_ALLOC */
GLBK_DEF void glbk_rsm_map_matrix(const glbk_rsm_map *map, uint32_t face, float world_to_clip[16]);
GLBK_DEF void glbk_rsm_map_destroy(glbk_context *ctx, glbk_rsm_map *map);

typedef struct glbk_rsm_renderer_desc {
    uint32_t width, height;
    int      interpolate, denoise;      /* not 0: memory for glbk_rsm_gather with a grid, for glbk_rsm_denoise */
} glbk_rsm_renderer_desc;

#define GLBK_RSM_PROGRAMS 25u

typedef struct glbk_rsm_renderer {      /* read only; zeroed = none */
    glbk_program programs[GLBK_RSM_PROGRAMS];       /* compiled when first needed */
    glbk_texture seen[2], depth, sums[3], grids[3], history[2], lights;
    glbk_target  seen_targets[2], targets[3], grid_targets[3], history_targets[2], lights_target;
    glbk_texture pattern, noise, materials;
    uint32_t     points, noise_side, material_count;
    glbk_buffer  frame, object;
    glbk_rsm_frame values;
    glbk_rsm_drawn drawn;
    float        before[16];
    uint32_t     width, height, now, direct, bounce, remembers;
    int          has_before, drawing, turn;
    glbk_result  failed;                /* first of glbk_rsm_object while drawing */
    int          compute;               /* glbk_rsm_gather and _denoise dispatch: ctx->compute when it was made */
    glbk_buffer  counts, open[2], wanted, marks;        /* then, with interpolate: lists of pixels */
} glbk_rsm_renderer;

GLBK_DEF glbk_result glbk_rsm_renderer_create(glbk_context *ctx, const glbk_rsm_renderer_desc *desc,
                                              glbk_rsm_renderer *out);
/* Memory on the GPU: 4 MB, and 100 bytes a pixel, with interpolate 13 more, with denoise 80 more. */
GLBK_DEF void glbk_rsm_renderer_destroy(glbk_context *ctx, glbk_rsm_renderer *renderer);

typedef struct glbk_rsm_tables {
    const float *points;                /* of patterns about the receiver: rsm_pattern_build, 3 floats each, or NULL */
    uint32_t     point_count;
    const float *noise;                 /* rsm_blue_noise, noise_side^2 values, or NULL: patterns are not turned */
    uint32_t     noise_side;
    const float *materials;             /* rsm_material: specular, exponent; or NULL: all diffuse */
    uint32_t     material_count;        /* at most 1024 */
} glbk_rsm_tables;

GLBK_DEF glbk_result glbk_rsm_tables_upload(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                            const glbk_rsm_tables *tables);
/* Replaces all three. Errors: GLBK_ERR_ARGUMENT, GLBK_ERR_LIMIT (more than 2^20 points), GLBK_ERR_ALLOC */

typedef void (*glbk_rsm_draw)(void *user, glbk_context *ctx, glbk_rsm_renderer *renderer);
/* Your scene: for each object glbk_rsm_object, then a draw with attributes 0 position, 1 normal, 2 texture coordinates
   from your vertex array. An attribute that is not enabled must be zero; normals of zero are those of the triangles. */

typedef struct glbk_rsm_surface {
    float               transform[16];  /* object to world, affine */
    float               albedo[3];      /* linear */
    uint32_t            material;       /* 1 + index into glbk_rsm_tables.materials, 0 = diffuse */
    const glbk_texture *albedo_map;     /* or NULL. Use GLBK_SAMPLING_MIPMAPS: flux is filtered then (section 6) */
    float               alpha_cutoff;   /* of the map's alpha at full size; below it is a hole */
} glbk_rsm_surface;

GLBK_DEF glbk_result glbk_rsm_object(glbk_context *ctx, glbk_rsm_renderer *renderer, const glbk_rsm_surface *surface);
/* Only from within a glbk_rsm_draw. Its first error is what the call that draws returns, too. */

GLBK_DEF glbk_result glbk_rsm_map_draw(glbk_context *ctx, glbk_rsm_renderer *renderer, glbk_rsm_map *map,
                                       glbk_rsm_draw draw, void *user);
/* Calls draw once a face. Both sides of triangles, normals turned to the light. */
GLBK_DEF glbk_result glbk_rsm_gbuffer_draw(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                           const float world_to_clip[16], const float eye[3], glbk_rsm_draw draw,
                                           void *user);

typedef struct glbk_rsm_pixel {
    float position[3], normal[3];       /* world; normal 0 0 0: nothing is seen */
    float albedo[3];
    float occlusion;                    /* factor of bounced light, 0..1: 1 = none */
} glbk_rsm_pixel;

GLBK_DEF glbk_result glbk_rsm_gbuffer_upload(glbk_context *ctx, glbk_rsm_renderer *renderer, uint32_t row,
                                             uint32_t rows, const glbk_rsm_pixel *pixels);
/* Whole rows from the CPU. Row 0 comes back first from glbk_rsm_read. Errors: GLBK_ERR_ALLOC */

typedef struct glbk_rsm_direct_desc {   /* rsm_direct_desc */
    uint32_t taps;                      /* 1..15; 0 = 2 */
    float    bias, slope_bias;          /* 0 really is none; 0.5 and 1 are good */
} glbk_rsm_direct_desc;

GLBK_DEF glbk_result glbk_rsm_direct(glbk_context *ctx, glbk_rsm_renderer *renderer, const glbk_rsm_map *const *maps,
                                     uint32_t count, const glbk_rsm_direct_desc *desc);

typedef enum glbk_rsm_pattern {         /* rsm_pattern; ABOUT: whatever glbk_rsm_tables.points holds */
    GLBK_RSM_PATTERN_DEFAULT,           /* = GLBK_RSM_PATTERN_FLUX */
    GLBK_RSM_PATTERN_FLUX, GLBK_RSM_PATTERN_ABOUT, GLBK_RSM_PATTERN_MIXED = 6, GLBK_RSM_PATTERN_COUNT
} glbk_rsm_pattern;

typedef struct glbk_rsm_gather_desc {   /* rsm_gather_desc; noise and materials are used where the tables have them */
    glbk_rsm_pattern pattern;
    uint32_t samples;                   /* of each pixel and map; 0 = every texel. ABOUT: all points of the tables
                                           count. MIXED: samples - 3 * samples / 5 by flux, the tables' points
                                           (log-radial, r_min 1 / 192) too */
    float    r_max, offset, clamp, near_limit;
    uint32_t seed, interleave;
    uint32_t lights_per_pass;           /* 0 = 4096, at most 32768: a pass must not outlast the driver's patience */
    float    near_field;                /* of every texel, ABOUT and MIXED; a program of your own that is to have it,
                                           too, needs RSM_SURFACES=1 among its defines */
} glbk_rsm_gather_desc;

typedef struct glbk_rsm_grid {          /* rsm_interpolation */
    uint32_t step, levels;
    float    normal_cosine, plane_slope, distance, contrast, reach;
} glbk_rsm_grid;

GLBK_DEF glbk_result glbk_rsm_gather(glbk_context *ctx, glbk_rsm_renderer *renderer, glbk_rsm_map *const *maps,
                                     uint32_t count, const glbk_rsm_gather_desc *desc, const glbk_rsm_grid *grid);
/* Bounced light of all maps. grid: first a low-resolution picture, then the pixels between where 3 of 4 samples suit,
   then finer grids, at last single pixels, each only where a mask in alpha, or by compute a list, says that something
   is left: nothing is asked back from the GPU. NULL: every pixel.
   The choice of samples, and so the noise, is rsm_gather's for the same desc.
   Errors   GLBK_ERR_ARGUMENT (desc or grid as rsm.h refuses them; interleave, noise with a grid; pattern without
   points) */

typedef struct glbk_rsm_denoise_desc {  /* rsm_filter_desc */
    const float        *view_projection;
    const glbk_texture *motion;         /* NULL, or where each pixel's surface was: pixels of the last frame in r and
                                           g */
    int                 top_first;      /* not 0: row 0 of the G-buffer is the picture's top */
    uint32_t            history, passes;
    float               normal_cosine, plane_slope;
} glbk_rsm_denoise_desc;

GLBK_DEF glbk_result glbk_rsm_denoise(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                      const glbk_rsm_denoise_desc *desc);
/* Once a frame, after glbk_rsm_gather. Fill the whole G-buffer anew for the next frame: two are kept in turn. */
GLBK_DEF void glbk_rsm_forget(glbk_rsm_renderer *renderer);
/* The next frame starts anew. */

GLBK_DEF glbk_result glbk_rsm_resolve(glbk_context *ctx, glbk_rsm_renderer *renderer, const glbk_pass *pass, int direct,
                                      int bounced);
/* Draws albedo / pi times the light that is wanted, linear radiance, to the pass's target; viewports: see glbk_pass. */

GLBK_DEF glbk_result glbk_rsm_read(glbk_context *ctx, glbk_rsm_renderer *renderer, int bounced, float *rgba);
/* Irradiance, direct or bounced: 4 floats a pixel. Waits for the GPU. a of bounced light, before glbk_rsm_denoise: 2
   interpolated, above evaluated, 0 nothing seen. */

GLBK_DEF void glbk_rsm_bind(glbk_context *ctx, const glbk_rsm_renderer *renderer, const glbk_rsm_map *map);
/* For a program of yours with rsm_direct, rsm_gather or rsm_bounce among its library files, which is bound: the map's
   textures and light; with a renderer its list of lights as the last glbk_rsm_gather left it, tables and G-buffer.
   Either may be NULL.
   By flux, without interleave, the list holds the samples of one map after the other, of all if they are
   lights_per_pass or fewer, else their last ones. Where nothing but the list is wanted, a renderer of 1 x 1 pixels
   does. */

/* ---- end of rsm ---- */

/* ---- ism: imperfect shadow maps, after ism.h ----

   ism.h chooses VPLs (ism_choose) and scatters points over the mesh (ism_scatter); from plain arrays of both the maps
   are drawn and pixels shaded here: points as discs by the depth test, pull and push, light of all VPLs with
   visibility, interleaved sampling and its blur. Where ctx->compute, each of these is one dispatch that works in shared
   memory, to the same numbers. Points are triangles and barycentric coordinates, the mesh two tables of indices
   and positions: moving geometry is new positions alone. The numbers are those of ism.h to float rounding.
   In every frame: glbk_ism_phase, glbk_ism_vpls_upload, glbk_ism_draw, glbk_ism_shade. For shaders of your own,
   lib/ism_light.glsl with glbk_ism_bind:

       vec4 ism_light(vec3 p, vec3 n, vec3 ng, uint first, uint pattern);
       float ism_visible(uint v, ism_vpl l, vec3 p, vec3 ng, float bias);     // 1 lit, 0 not; l: ism_read_vpl(v)

   World space; n, ng: unit, for shading and the surface's own. VPLs first, first + pattern, ... (0u, 1u: all), times
   pattern. Result: rgb irradiance, W/m^2; a: what the rule near by took off, mean of the channels. */

#define GLBK_ISM_TEXTURES(X)                                                                        \
    X(sampler2DArray, glbk_ism_vpls, 0)         /* 4 texels each; spheres of near points; these, 3 each */  \
    X(usampler2DArray, glbk_ism_points, 1)                                                          \
    X(usampler2DArray, glbk_ism_triangles, 2)   /* three indices, opacity */                        \
    X(sampler2DArray, glbk_ism_positions, 3)                                                        \
    X(glbk_color_sampler, glbk_ism_surfels, 5)  /* plane and depth */                               \
    X(usampler2D, glbk_ism_below, 6)            /* texels that are kept, or the level below */      \
    X(usampler2D, glbk_ism_pull1, 7)                                                                \
    X(usampler2D, glbk_ism_pull2, 8)                                                                \
    X(usampler2D, glbk_ism_pull3, 9)                                                                \
    X(usampler2D, glbk_ism_atlas, 10)           /* depths, floats as bits */                        \
    X(glbk_color_sampler, glbk_ism_place, 11)   /* G-buffer */                                      \
    X(glbk_color_sampler, glbk_ism_normal, 12)                                                      \
    X(glbk_color_sampler, glbk_ism_geometric, 13)                                                   \
    X(glbk_color_sampler, glbk_ism_albedo, 14)                                                      \
    X(glbk_color_sampler, glbk_ism_light, 15)   /* before the blur */

#define GLBK_ISM_FRAME_MEMBERS(X)                                                                   \
    X(uvec4, maps, 1)       /* VPLs in use, texels a tile's side, tiles a side, points of a VPL in all phases */     \
    X(uvec4, points, 1)     /* VPLs at most, points of one in a phase, levels of the fill, triangles */  \
    X(vec4, sphere, 1)      /* about the mesh: centre, radius */                                    \
    X(vec4, values, 1)      /* area of a disc over its point's; texels a tile's side outside of windows */  \
    X(uvec4, near_points, 1) /* how many; where their spheres and they themselves begin in glbk_ism_vpls; first point
                               of a draw of rectangles */
#define GLBK_ISM_VIEW_MEMBERS(X)                                                                    \
    X(uvec4, size, 1)       /* width, height (resolving: corner), pattern; 1: no maps, 2: times albedo */ \
    X(vec4, values, 1)      /* bias, clamp, first row of a dispatch */
#define GLBK_ISM_BLOCKS(X)                          \
    X(glbk_ism_frame, 0, GLBK_ISM_FRAME_MEMBERS)    \
    X(glbk_ism_view, 1, GLBK_ISM_VIEW_MEMBERS)
#define GLBK_ISM_STORAGE(X)
#define GLBK_ISM_IMAGES(X)                                              \
    X(writeonly, rgba32f, image2D, glbk_ism_surfels_out, 0)             \
    X(writeonly, r32ui, uimage2D, glbk_ism_atlas_out, 1)                \
    X(writeonly, rgba32f, image2D, glbk_ism_light_out, 2)       /* before the blur, or after it */

GLBK__PART(ISM)

typedef struct glbk_ism_desc {      /* fields as in ism_desc */
    uint32_t vpl_count;             /* at most, 1..16384; 0 = 1024 */
    uint32_t points;                /* of each VPL, 8..65536; 0 = 8192 */
    uint32_t tile_size;             /* texels a side, power of two, 8..256; 0 = 64 */
    uint32_t projection;            /* ism_projection; 0 = cosine */
    uint32_t lazy;                  /* frames until all points are renewed, 1..64; 0 = 8 */
    float    splat_scale;           /* above 0, <= 16; 0 = 1 */
    int      no_fill;               /* not 0: no pull and push */
    uint32_t near_points;           /* of each VPL, at most 64; 0 = 16 */
    uint32_t window_rim;            /* 2..tile_size / 2; 0 = tile_size / 8, at least 2 */
    uint32_t points_per_pass;       /* of the core path; 0 = 2^20: a draw must not outlast the driver's patience */
} glbk_ism_desc;

#define GLBK_ISM_LEVELS 3u

typedef struct glbk_ism_maps {      /* read only; zeroed = none */
    glbk_ism_desc desc;             /* defaults resolved */
    uint32_t      side, tiles;      /* of the atlas, in texels and tiles */
    uint32_t      each;             /* points of a VPL in a phase */
    uint32_t      count;            /* VPLs in use */
    uint32_t      vertices, triangles;
    uint64_t      phases;           /* bits: those that were given */
    float         sphere[4];
    glbk_texture  vpls, points, triangle_table, positions, surfels, depth, kept, pull[GLBK_ISM_LEVELS], atlas;
    glbk_target   surfel_target, kept_target, pull_target[GLBK_ISM_LEVELS], atlas_target;
    glbk_buffer   frame, view;      /* view: of glbk_ism_bind */
    int           quads;            /* rectangles in place of points */
    glbk_program  splat, holes, pull_program[GLBK_ISM_LEVELS], push;
    int           compute;          /* the compute path: no depth, kept and pull */
    glbk_program  fill;
    uint32_t      near_count;       /* near points in use */
    glbk_texture  phase_points[64]; /* the core path's in place of points, so that those drawn with are left alone */
} glbk_ism_maps;

GLBK_DEF glbk_result glbk_ism_maps_create(glbk_context *ctx, const glbk_ism_desc *desc, glbk_ism_maps *out);
/* desc     NULL = all defaults
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_LIMIT where the atlas is wider than ctx->max_size; GLBK_ERR_COMPILE and so on
   Where ctx->compute, out->compute: the compute path, unless points rounded up to lazy phases are more than 65,536 a
   VPL. Memory on the GPU: 26 bytes a texel of the atlas, by compute 20, and 16 a point: 1024 VPLs of 64 x 64 texels and
   8192 points 109 (84) + 134 MB */
GLBK_DEF void glbk_ism_maps_destroy(glbk_context *ctx, glbk_ism_maps *maps);

typedef struct glbk_ism_mesh {      /* fields as in ism_mesh */
    const float    *positions;
    size_t          vertex_count, vertex_stride;    /* stride in bytes, 0 = 12 */
    const uint32_t *indices;        /* NULL = 0, 1, 2, ... */
    size_t          index_count;
    const float    *opacities;      /* of each triangle, or NULL */
} glbk_ism_mesh;

GLBK_DEF glbk_result glbk_ism_mesh_upload(glbk_context *ctx, glbk_ism_maps *maps, const glbk_ism_mesh *mesh);
/* What throws shadows. Where the number of triangles changes all points must be given anew.
   mesh     NULL = nothing
   Errors   GLBK_ERR_ARGUMENT: sizes, or an index beyond vertex_count; GLBK_ERR_LIMIT, GLBK_ERR_ALLOC */
GLBK_DEF glbk_result glbk_ism_mesh_move(glbk_context *ctx, glbk_ism_maps *maps, const float *positions, size_t stride);
/* New places of the same vertices. Or render them into layers of maps->positions, an RGBA32F table, yourself; points
   are then scattered by ism.h over the places that you give it. Errors: GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC. */

GLBK_DEF glbk_result glbk_ism_phase(glbk_context *ctx, glbk_ism_maps *maps, uint32_t phase, const void *points);
/* The points of one phase, 16 bytes each, of all VPLs, as ism_phase_points writes them: vpl_count * maps->each.
   phase    below lazy; a frame changes phase index % lazy alone, the first frame needs all
   Errors   GLBK_ERR_ARGUMENT */

typedef struct glbk_ism_vpl {       /* fields as in ism_vpl */
    float position[3], normal[3], flux[3], axis[3], exponent, side;
    int   directional;
    float reach;                    /* counts once near points are given */
    uint32_t window;                /* 0 = none; ism_scatter sets ism_vpl's */
} glbk_ism_vpl;

GLBK_DEF glbk_result glbk_ism_vpls_upload(glbk_context *ctx, glbk_ism_maps *maps, const glbk_ism_vpl *vpls,
                                          uint32_t count, const float center[3], float radius);
/* count    <= vpl_count; 0 is no light
   center   and radius: ism_bounds, for directional VPLs; NULL without
   There are no near points afterwards, until glbk_ism_near_upload.
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC */
GLBK_DEF glbk_result glbk_ism_near_upload(glbk_context *ctx, glbk_ism_maps *maps, const void *points, uint32_t count);
/* After glbk_ism_vpls_upload, for near_mode 6.
   points   count times 48 bytes, as ism_near_points has them
   count    <= vpl_count * near_points; 0 is none: near_mode 6 then is 1
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_ism_draw(glbk_context *ctx, glbk_ism_maps *maps);
/* Draws all maps: a draw for each phase or points_per_pass of it, then 1 + 3 + 1 passes, or by compute two dispatches.
   Where ctx->max_point_size is below tile_size, the core path has rectangles instead of points.
   Errors   GLBK_ERR_ARGUMENT: a phase was not given yet; GLBK_ERR_LOST */
GLBK_DEF glbk_result glbk_ism_read(glbk_context *ctx, const glbk_ism_maps *maps, float *atlas);
/* side * side depths as ism_atlas has them. Waits for the GPU. Errors: GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC. */

typedef struct glbk_ism_renderer {  /* read only; zeroed = none */
    uint32_t     width, height;
    glbk_texture gbuffer[4], depth; /* places, normals, face normals, albedos: GLBK_FORMAT_COLOR */
    glbk_target  gbuffer_target;    /* to draw them yourself: four outputs of type glbk_color, a cleared normal is
                                       background */
    glbk_texture light, result;     /* result is what was asked for: GLBK_FORMAT_COLOR, for your own passes */
    glbk_target  light_target, result_target;
    glbk_buffer  view;
    glbk_program shade[4][6], blur, resolve;        /* shade: by projection and near_mode */
    int          compute;
} glbk_ism_renderer;

GLBK_DEF glbk_result glbk_ism_renderer_create(glbk_context *ctx, uint32_t width, uint32_t height,
                                              glbk_ism_renderer *out);
GLBK_DEF void glbk_ism_renderer_destroy(glbk_context *ctx, glbk_ism_renderer *renderer);

typedef struct glbk_ism_receivers { /* fields as in ism_view: width * height of each, row 0, the lowest, first */
    const float *positions, *normals;
    const float *geometric;         /* NULL = normals */
    const float *albedos;           /* NULL = 1 */
    size_t       stride;            /* bytes, of all four; 0 = 12 */
} glbk_ism_receivers;

GLBK_DEF glbk_result glbk_ism_gbuffer_upload(glbk_context *ctx, glbk_ism_renderer *renderer,
                                             const glbk_ism_receivers *receivers);
/* Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC */

typedef struct glbk_ism_shading {   /* fields as in ism_shading. NULL for one: all 0 but bias 0.02 and clamp 1; in one a
                                       bias of 0 is 0 */
    uint32_t pattern;               /* 1, 2, 4, 8; 0 = 1 */
    uint32_t near_mode;             /* ism_near; 0 = 6, gather */
    float    clamp, bias;
    int      no_maps;
    int      irradiance;            /* not 0: not times albedo / pi */
    uint32_t pairs_per_pass;        /* of a pixel and a VPL; 0 = 2^28: likewise */
} glbk_ism_shading;

GLBK_DEF glbk_result glbk_ism_bind(glbk_context *ctx, const glbk_ism_maps *maps, const glbk_ism_shading *shading);
/* For ism_light() and ism_visible() of lib/ism_light.glsl in a program of your own, which is bound (glbk_begin) and
   compiled with ISM_NEAR=near_mode and ISM_PROJECTION=maps->desc.projection among its defines.
   shading  bias, clamp and no_maps count; may be NULL, see glbk_ism_shading
   Errors   GLBK_ERR_ARGUMENT */

GLBK_DEF glbk_result glbk_ism_shade(glbk_context *ctx, glbk_ism_renderer *renderer, const glbk_ism_maps *maps,
                                    const glbk_ism_shading *shading);
/* shading  may be NULL, see glbk_ism_shading
   Errors   GLBK_ERR_ARGUMENT; those of glbk_program_create at a near_mode's first use */
GLBK_DEF glbk_result glbk_ism_resolve(glbk_context *ctx, glbk_ism_renderer *renderer, const glbk_pass *pass);
/* Draws the result, linear, to the pass's target; its blending adds it to what is there. Viewports: see glbk_pass.
   Errors GLBK_ERR_ARGUMENT; those of glbk_buffer_update */
GLBK_DEF glbk_result glbk_ism_read_light(glbk_context *ctx, const glbk_ism_renderer *renderer, float *rgb);
/* width * height * 3 floats, row 0, the lowest, first. Waits for the GPU. result's fourth channel is the irradiance,
   mean of the three channels, that clamping or spheres took off. Errors: GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC. */

/* ---- end of ism ---- */

/* ---- end of the techniques ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_BACKEND_H */

/* ==== implementation ============================================================================================== */

#if defined(GL_BACKEND_IMPLEMENTATION) && !defined(GL_BACKEND_IMPLEMENTED)
#define GL_BACKEND_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* >>> shared mem v3 m4: written by tools/stamp from src/shared, edit there */

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

/* Bytes between elements of floats that are `standard` large: 0 stands for that; else they do not overlap. */
static inline int glbk__stride_valid(size_t stride, size_t standard)
{
    return stride == 0 || (stride >= standard && stride % 4 == 0);
}

/* Takes the members of a public desc. Both functions or none: valid() is what the desc check asks. */
static inline int glbk__allocator_valid(void *(*alloc_fn)(size_t, void *), void (*free_fn)(void *, void *))
{
    return (alloc_fn == NULL) == (free_fn == NULL);
}

static inline glbk__allocator glbk__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
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

/* unit v3: three floats */

/* tcc 0.9.27 stores a returned struct of 12 bytes as 16, over the caller's next variable. */
typedef struct glbk__v3 {
    float x, y, z;
#ifdef __TINYC__
    float unused;
#endif
} glbk__v3;

static inline glbk__v3 glbk__v3_make(float x, float y, float z)
{
    glbk__v3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

static inline glbk__v3 glbk__v3_load(const float *p) { return glbk__v3_make(p[0], p[1], p[2]); }
static inline void glbk__v3_store(float *p, glbk__v3 v) { p[0] = v.x; p[1] = v.y; p[2] = v.z; }

static inline glbk__v3 glbk__v3_sub(glbk__v3 a, glbk__v3 b)
{
    return glbk__v3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline glbk__v3 glbk__v3_scale(glbk__v3 a, float s)
{
    return glbk__v3_make(a.x * s, a.y * s, a.z * s);
}

static inline float glbk__v3_dot(glbk__v3 a, glbk__v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float glbk__v3_length(glbk__v3 a)
{
    return sqrtf(glbk__v3_dot(a, a));
}

static inline glbk__v3 glbk__v3_cross(glbk__v3 a, glbk__v3 b)
{
    return glbk__v3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/* Scaled by the largest component first, so that neither tiny nor huge vectors leave the float range.
   The zero vector stays zero. */
static inline glbk__v3 glbk__v3_normalize(glbk__v3 a)
{
    float x = fabsf(a.x), y = fabsf(a.y), z = fabsf(a.z), m = x > y ? x : y;
    m = m > z ? m : z;
    if (!(m > 0.0f)) return glbk__v3_make(0.0f, 0.0f, 0.0f);
    if (m < 1e-30f) {
        a = glbk__v3_scale(a, 1e30f);
        m *= 1e30f;
    }
    a = glbk__v3_make(a.x / m, a.y / m, a.z / m);
    m = glbk__v3_length(a);
    return glbk__v3_make(a.x / m, a.y / m, a.z / m);
}

/* By the exponent bits, because compilers may take isfinite() for always true under -ffast-math. */
static inline int glbk__finite(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7f800000u) != 0x7f800000u;
}

/* b1, b2, n right-handed and orthonormal for a unit n. Duff et al., "Building an orthonormal basis, revisited",
   JCGT 6(1), 2017; n.z = -0 and n.z = -1 included. */
static inline void glbk__v3_basis(glbk__v3 n, glbk__v3 *b1, glbk__v3 *b2)
{
    float s = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + n.z), b = n.x * n.y * a;
    *b1 = glbk__v3_make(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
    *b2 = glbk__v3_make(b, s + n.y * n.y * a, -n.y);
}

/* unit m4, needs v3: column-major 4 x 4 matrices, float[16], affine */

static inline glbk__v3 glbk__m4_point(const float *m, glbk__v3 p)
{
    return glbk__v3_make(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12], m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                     m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]);
}

/* Finite, with 0 0 0 1 as its last row. */
static inline int glbk__m4_is_affine(const float *m)
{
    int i;
    for (i = 0; i < 16; i++)
        if (!glbk__finite(m[i])) return 0;
    return m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f && m[15] == 1.0f;
}

/* out = m^-1 and 1; 0 and out untouched where m is singular to float precision: the determinant against the product
   of the column lengths, so that the test is free of scale. In double: the inverse of a badly scaled matrix is used
   on points. out may be m. */
static inline int glbk__m4_affine_inverse(float *out, const float *m)
{
    double a = (double)m[0], b = (double)m[4], c = (double)m[8];
    double d = (double)m[1], e = (double)m[5], f = (double)m[9];
    double g = (double)m[2], h = (double)m[6], k = (double)m[10];
    double tx = (double)m[12], ty = (double)m[13], tz = (double)m[14];
    double ca = e * k - f * h, cb = f * g - d * k, cc = d * h - e * g;
    double det = a * ca + b * cb + c * cc;
    double size = sqrt((a * a + d * d + g * g) * (b * b + e * e + h * h)) * sqrt(c * c + f * f + k * k);
    double r[12];
    int i;

    if (!(det > 1e-7 * size || det < -1e-7 * size)) return 0;
    r[0] = ca / det;
    r[1] = cb / det;
    r[2] = cc / det;
    r[3] = (c * h - b * k) / det;
    r[4] = (a * k - c * g) / det;
    r[5] = (b * g - a * h) / det;
    r[6] = (b * f - c * e) / det;
    r[7] = (c * d - a * f) / det;
    r[8] = (a * e - b * d) / det;
    for (i = 0; i < 3; i++) r[9 + i] = -(r[i] * tx + r[3 + i] * ty + r[6 + i] * tz);
    for (i = 0; i < 12; i++)
        if (!glbk__finite((float)r[i])) return 0;
    for (i = 0; i < 4; i++) {
        out[4 * i] = (float)r[3 * i];
        out[4 * i + 1] = (float)r[3 * i + 1];
        out[4 * i + 2] = (float)r[3 * i + 2];
        out[4 * i + 3] = i == 3 ? 1.0f : 0.0f;
    }
    return 1;
}

/* 1 and *scale where m is a rotation times one scale > 0 (no mirroring) plus a translation: columns of equal length
   and at right angles within 1e-4, which is what products of float rotations reach. */
static inline int glbk__m4_is_rigid_uniform(const float *m, float *scale)
{
    glbk__v3 x = glbk__v3_load(m), y = glbk__v3_load(m + 4), z = glbk__v3_load(m + 8);
    float s, lx, ly, lz, tolerance;

    if (!glbk__m4_is_affine(m)) return 0;
    lx = glbk__v3_length(x);
    ly = glbk__v3_length(y);
    lz = glbk__v3_length(z);
    if (!(lx > 0.0f && ly > 0.0f && lz > 0.0f) || !glbk__finite(lx + ly + lz)) return 0;
    s = (lx + ly + lz) / 3.0f;
    tolerance = 1e-4f * s;
    if (fabsf(lx - s) > tolerance || fabsf(ly - s) > tolerance || fabsf(lz - s) > tolerance) return 0;
    x = glbk__v3_scale(x, 1.0f / lx);
    y = glbk__v3_scale(y, 1.0f / ly);
    z = glbk__v3_scale(z, 1.0f / lz);
    if (fabsf(glbk__v3_dot(x, y)) > 1e-4f || fabsf(glbk__v3_dot(x, z)) > 1e-4f) return 0;
    if (fabsf(glbk__v3_dot(y, z)) > 1e-4f || glbk__v3_dot(glbk__v3_cross(x, y), z) < 0.0f) return 0;
    *scale = s;
    return 1;
}

/* <<< shared */

/* >>> glsl: written by tools/embed from src/shaders and GLBK_PARTS, edit there */

static const char *const glbk__glsl_lib_base_bindings_glsl[] = {
    "// base_bindings - from the lists GLBK_BASE_* of gl_backend.h.\n",
    "uniform glbk_color_sampler glbk_source;\n"
};

static const char *const glbk__glsl_lib_cohsm_brdf_glsl[] = {
    "// cohsm_brdf - Lambert, Phong, Lafortune and glTF's metal-rough GGX: evaluation, densities, sampling.\n",
    "// C twins: cohsm_brdf_eval and cohsm_brdf_sample of csm.h.\n",
    "//\n",
    "// COHSM_LOBES: lobes that a surface may have, 1 unless there are Lafortune materials of more, at most 8. Registers grow\n",
    "// with it. COHSM_LOBE(i): uvec4 texel i of the lobes' table, two each: axis and exponent, scale (as float bits).\n",
    "// uses: cohsm_math\n",
    "#ifndef COHSM_LOBES\n",
    "#error \"cohsm_brdf.glsl needs COHSM_LOBES, 1..8\"\n",
    "#endif\n",
    "#ifndef COHSM_LOBE\n",
    "#error \"cohsm_brdf.glsl needs COHSM_LOBE(i), the uvec4 at texel i of the lobes\"\n",
    "#endif\n",
    "\n",
    "#define COHSM_BRDF_LAMBERT 1u\n",
    "#define COHSM_BRDF_PHONG 2u\n",
    "#define COHSM_BRDF_LAFORTUNE 3u\n",
    "#define COHSM_BRDF_METAL_ROUGH 4u\n",
    "\n",
    "struct cohsm_material {\n",
    "    uint type;\n",
    "    vec3 diffuse;               // albedo; metal-rough: base colour\n",
    "    vec3 specular;              // PHONG\n",
    "    float exponent;             // PHONG\n",
    "    float metallic, roughness;  // METAL_ROUGH\n",
    "    uint lobe, lobe_count;      // LAFORTUNE: the first one\n",
    "};\n",
    "\n",
    "struct cohsm_surface {          // a material at a point; directions in the frame t, b, n\n",
    "    vec3  t, b, n, wo, diffuse, f0;\n",
    "    float alpha;                // GGX; 0: cosine lobes\n",
    "    int   lobe_count;\n",
    "    vec4  lobes[COHSM_LOBES];   // axis, exponent\n",
    "    vec4  scales[COHSM_LOBES];  // scale, share of the roulette\n",
    "    float diffuse_share, peak;\n",
    "    bool  black;\n",
    "};\n",
    "\n",
    "struct cohsm_response { vec3 diffuse, specular; float diffuse_pdf, specular_pdf; };\n",
    "\n",
    "float cohsm_mean(vec3 c) { return (c.x + c.y + c.z) * (1.0 / 3.0); }\n",
    "vec3 cohsm_to_frame(cohsm_surface s, vec3 w) { return vec3(dot(w, s.t), dot(w, s.b), dot(w, s.n)); }\n",
    "vec3 cohsm_from_frame(cohsm_surface s, vec3 w) { return s.t * w.x + s.b * w.y + s.n * w.z; }\n",
    "\n",
    "vec3 cohsm_schlick(vec3 f0, float cosine)\n",
    "{\n",
    "    float x = 1.0 - cosine, f = x * x * (x * x) * x;\n",
    "    return f0 * (1.0 - f) + f;\n",
    "}\n",
    "\n",
    "float cohsm_add_lobe(inout cohsm_surface s, vec3 c, float exponent, vec3 scale)\n",
    "{\n",
    "    vec3 a = c * s.wo;\n",
    "    float size = sqrt(dot(a, a));\n",
    "    if (!(size > 0.0) || s.lobe_count >= COHSM_LOBES) return 0.0;\n",
    "    a /= size;\n",
    "    if (exponent > 0.0) scale *= cohsm_pow(size, exponent);\n",
    "    float albedo = cohsm_mean(scale) * 2.0 * COHSM_PI / (exponent + 2.0) * max(a.z, 0.1);\n",
    "    if (!(albedo > 0.0) || !cohsm_finite3(scale)) return 0.0;\n",
    "    s.lobes[s.lobe_count] = vec4(a, exponent);\n",
    "    s.scales[s.lobe_count] = vec4(scale, albedo);\n",
    "    s.lobe_count++;\n",
    "    return albedo;\n",
    "}\n",
    "\n",
    "float cohsm_specular_init(inout cohsm_surface s, cohsm_material m)\n",
    "{\n",
    "    if (m.type == COHSM_BRDF_METAL_ROUGH) {\n",
    "        s.alpha = max(m.roughness * m.roughness, 0.002);\n",
    "        s.f0 = vec3(0.04) * (1.0 - m.metallic) + m.diffuse * m.metallic;\n",
    "        s.diffuse = m.diffuse * (1.0 - m.metallic);\n",
    "        s.lobe_count = 1;\n",
    "        float share = cohsm_mean(cohsm_schlick(s.f0, s.wo.z));\n",
    "        s.scales[0] = vec4(0.0, 0.0, 0.0, share);\n",
    "        return share;\n",
    "    }\n",
    "    if (m.type == COHSM_BRDF_PHONG)\n",
    "        return cohsm_add_lobe(s, vec3(-1.0, -1.0, 1.0), m.exponent,\n",
    "                              m.specular * ((m.exponent + 2.0) / (2.0 * COHSM_PI)));\n",
    "    float sum = 0.0;\n",
    "    if (m.type == COHSM_BRDF_LAFORTUNE)\n",
    "        for (uint i = 0u; i < m.lobe_count; i++) {\n",
    "            vec4 axis = uintBitsToFloat(COHSM_LOBE(2u * (m.lobe + i)));\n",
    "            sum += cohsm_add_lobe(s, axis.xyz, axis.w, uintBitsToFloat(COHSM_LOBE(2u * (m.lobe + i) + 1u)).xyz);\n",
    "        }\n",
    "    return sum;\n",
    "}\n",
    "\n",
    "// tangent: any length; zero for none. normal and wo: about unit length.\n",
    "cohsm_surface cohsm_surface_at(cohsm_material m, vec3 normal, vec3 tangent, vec3 wo)\n",
    "{\n",
    "    cohsm_surface s;\n",
    "    s.n = cohsm_normalize(normal);\n",
    "    vec3 t = tangent - s.n * dot(tangent, s.n);\n",
    "    if (dot(t, t) > 1e-6) {\n",
    "        s.t = cohsm_normalize(t);\n",
    "        s.b = cross(s.n, s.t);\n",
    "    } else\n",
    "        cohsm_basis(s.n, s.t, s.b);\n",
    "    s.wo = cohsm_to_frame(s, cohsm_normalize(wo));\n",
    "    if (s.wo.z < 1e-3) s.wo = cohsm_normalize(vec3(s.wo.xy, 1e-3));\n",
    "    s.wo.z = min(s.wo.z, 1.0);\n",
    "    s.diffuse = m.diffuse;\n",
    "    s.f0 = vec3(0.0);\n",
    "    s.alpha = 0.0;\n",
    "    s.lobe_count = 0;\n",
    "    for (int i = 0; i < COHSM_LOBES; i++) {\n",
    "        s.lobes[i] = vec4(0.0);\n",
    "        s.scales[i] = vec4(0.0);\n",
    "    }\n",
    "    float specular = cohsm_specular_init(s, m), diffuse = cohsm_mean(s.diffuse);\n",
    "    s.black = !(diffuse + specular > 0.0);\n",
    "    s.diffuse_share = s.black ? 1.0 : diffuse / (diffuse + specular);\n",
    "    s.peak = s.diffuse_share * (1.0 / COHSM_PI);\n",
    "    for (int i = 0; i < s.lobe_count; i++) {\n",
    "        s.scales[i].w /= specular;\n",
    "        float lobe = s.alpha > 0.0 ? 0.25 / (COHSM_PI * s.alpha * s.alpha) : (s.lobes[i].w + 1.0) / (2.0 * COHSM_PI);\n",
    "        s.peak += (1.0 - s.diffuse_share) * s.scales[i].w * lobe;\n",
    "    }\n",
    "    return s;\n",
    "}\n",
    "\n",
    "// GGX, Smith's height-correlated shadowing, density of visible normals.\n",
    "void cohsm_ggx(cohsm_surface s, vec3 wi, inout cohsm_response r)\n",
    "{\n",
    "    vec3 h = cohsm_normalize(s.wo + wi);\n",
    "    float a2 = s.alpha * s.alpha, q = h.x * h.x + h.y * h.y + a2 * h.z * h.z, d = a2 / (COHSM_PI * q * q);\n",
    "    float go = sqrt(a2 + (1.0 - a2) * s.wo.z * s.wo.z), gi = sqrt(a2 + (1.0 - a2) * wi.z * wi.z);\n",
    "    vec3 f = cohsm_schlick(s.f0, clamp(dot(s.wo, h), 0.0, 1.0));\n",
    "    r.specular = f * (0.5 * d / (wi.z * go + s.wo.z * gi));\n",
    "    r.diffuse *= 1.0 - f;\n",
    "    r.specular_pdf = 0.5 * d / (s.wo.z + go);\n",
    "}\n",
    "\n",
    "// f and the densities for wi in the frame, the diffuse and the specular part apart.\n",
    "cohsm_response cohsm_respond(cohsm_surface s, vec3 wi)\n",
    "{\n",
    "    cohsm_response r = cohsm_response(vec3(0.0), vec3(0.0), 0.0, 0.0);\n",
    "    if (!(wi.z > 0.0)) return r;\n",
    "    r.diffuse = s.diffuse * (1.0 / COHSM_PI);\n",
    "    r.diffuse_pdf = wi.z * (1.0 / COHSM_PI);\n",
    "    if (s.lobe_count > 0 && s.alpha > 0.0) {\n",
    "        cohsm_ggx(s, wi, r);\n",
    "        return r;\n",
    "    }\n",
    "    for (int i = 0; i < s.lobe_count; i++) {\n",
    "        float c = dot(s.lobes[i].xyz, wi);\n",
    "        if (!(c > 0.0)) continue;\n",
    "        c = cohsm_pow(c, s.lobes[i].w);\n",
    "        r.specular += s.scales[i].xyz * c;\n",
    "        r.specular_pdf += s.scales[i].w * c * (s.lobes[i].w + 1.0) / (2.0 * COHSM_PI);\n",
    "    }\n",
    "    return r;\n",
    "}\n",
    "\n",
    "float cohsm_brdf_pdf(cohsm_surface s, cohsm_response r)\n",
    "{\n",
    "    return s.diffuse_share * r.diffuse_pdf + (1.0 - s.diffuse_share) * r.specular_pdf;\n",
    "}\n",
    "\n",
    "// Visible normals by spherical caps (Dupuy and Benyoub 2023).\n",
    "vec3 cohsm_ggx_draw(cohsm_surface s, vec2 u)\n",
    "{\n",
    "    vec3 o = cohsm_normalize(vec3(s.wo.xy * s.alpha, s.wo.z));\n",
    "    float z = (1.0 - u.x) * (1.0 + o.z) - o.z, r = cohsm_safe_sqrt(1.0 - z * z);\n",
    "    vec2 sc = cohsm_sincos(2.0 * COHSM_PI * u.y);\n",
    "    vec3 h = vec3(r * sc.y, r * sc.x, z) + o;\n",
    "    h = cohsm_normalize(vec3(h.xy * s.alpha, h.z));\n",
    "    return cohsm_normalize(h * (2.0 * dot(s.wo, h)) - s.wo);\n",
    "}\n",
    "\n",
    "vec3 cohsm_lobe_draw(vec4 lobe, vec2 u)\n",
    "{\n",
    "    vec3 t, b;\n",
    "    float c = cohsm_pow(1.0 - u.x, 1.0 / (lobe.w + 1.0)), r = cohsm_safe_sqrt(1.0 - c * c);\n",
    "    vec2 sc = cohsm_sincos(2.0 * COHSM_PI * u.y);\n",
    "    cohsm_basis(lobe.xyz, t, b);\n",
    "    return t * (r * sc.y) + b * (r * sc.x) + lobe.xyz * c;\n",
    "}\n",
    "\n",
    "// wi in the frame, the lobe picked by u.x.\n",
    "vec3 cohsm_brdf_draw(cohsm_surface s, float diffuse_share, vec2 u)\n",
    "{\n",
    "    if (u.x < diffuse_share || s.lobe_count == 0) {\n",
    "        vec2 p = cohsm_concentric(vec2(diffuse_share > 0.0 ? cohsm_clamp_unit(u.x / diffuse_share) : u.x, u.y));\n",
    "        return vec3(p, cohsm_safe_sqrt(1.0 - p.x * p.x - p.y * p.y));\n",
    "    }\n",
    "    u.x = (u.x - diffuse_share) / (1.0 - diffuse_share);\n",
    "    if (s.alpha > 0.0) return cohsm_ggx_draw(s, vec2(cohsm_clamp_unit(u.x), u.y));\n",
    "    int i = 0;\n",
    "    for (; i + 1 < s.lobe_count && u.x >= s.scales[i].w; i++) u.x -= s.scales[i].w;\n",
    "    return cohsm_lobe_draw(s.lobes[i], vec2(cohsm_clamp_unit(u.x / s.scales[i].w), u.y));\n",
    "}\n"
};

static const char *const glbk__glsl_lib_cohsm_estimate_glsl[] = {
    "// cohsm_estimate - the direct-light estimator of section 5: one sample of a light at a surface with its weight.\n",
    "// Needs what cohsm_brdf.glsl and cohsm_light.glsl need. C twin: cohsm_sample of csm.h, sample by sample.\n",
    "//\n",
    "// COHSM_PATTERN(j, k): optional; point k of pattern j of 256 (cohsm_patterns_build). Without it a scrambled\n",
    "// (0, 2)-sequence a pixel, which converges faster over many frames.\n",
    "// uses: cohsm_brdf cohsm_light\n",
    "\n",
    "#define COHSM_SAMPLING_BOTH 0   // balance heuristic\n",
    "#define COHSM_SAMPLING_LIGHT 1\n",
    "#define COHSM_SAMPLING_BRDF 2\n",
    "#define COHSM_SAMPLING_PAPER 3\n",
    "\n",
    "struct cohsm_estimator {\n",
    "    uint  samples, seed, frame;\n",
    "    cohsm_surface surface;\n",
    "    cohsm_light light;\n",
    "    cohsm_aim aim;\n",
    "    bool  reachable, split;\n",
    "    float light_share;\n",
    "};\n",
    "\n",
    "vec3 cohsm_numbers(cohsm_estimator e, uint pixel, uint k)\n",
    "{\n",
    "    uint key = cohsm_hash_combine(e.seed, pixel), index = e.frame * e.samples + k;\n",
    "    vec3 u;\n",
    "#ifdef COHSM_PATTERN\n",
    "    u.xy = COHSM_PATTERN((key + e.frame * 159u) & 255u, k);\n",
    "    if (e.frame > 255u) {\n",
    "        u.xy += vec2(cohsm_random(key, e.frame >> 8, 0u), cohsm_random(key, e.frame >> 8, 1u));\n",
    "        u.xy -= floor(u.xy);\n",
    "        u.xy = vec2(cohsm_clamp_unit(u.x), cohsm_clamp_unit(u.y));\n",
    "    }\n",
    "#else\n",
    "    u.xy = cohsm_sobol2(index, key);\n",
    "#endif\n",
    "    u.z = e.light.shape == COHSM_SHAPE_MESH ? cohsm_random(key, 0x9e3779b9u, index) : 0.0;\n",
    "    return u;\n",
    "}\n",
    "\n",
    "// What all samples of a point share. samples: S; frame: of progressive rendering.\n",
    "cohsm_estimator cohsm_estimator_at(cohsm_surface surface, cohsm_light light, vec3 position, int sampling, uint samples,\n",
    "                                   uint seed, uint frame)\n",
    "{\n",
    "    cohsm_estimator e;\n",
    "    e.samples = samples;\n",
    "    e.seed = seed;\n",
    "    e.frame = frame;\n",
    "    e.surface = surface;\n",
    "    e.light = light;\n",
    "    e.reachable = cohsm_aim_at(light, position, e.aim) && !surface.black;\n",
    "    bool unseen = cohsm_light_is_delta(light) || light.shape == COHSM_SHAPE_MESH;\n",
    "    bool distant = light.shape == COHSM_SHAPE_ENVIRONMENT;\n",
    "    e.split = distant && sampling == COHSM_SAMPLING_PAPER;\n",
    "    e.light_share = 1.0;\n",
    "    if (unseen || sampling == COHSM_SAMPLING_LIGHT || !e.reachable) return e;\n",
    "    if (sampling == COHSM_SAMPLING_BRDF) e.light_share = 0.0;\n",
    "    else if (sampling == COHSM_SAMPLING_PAPER) e.light_share = distant ? surface.diffuse_share : 1.0;\n",
    "    else if (distant) e.light_share = 0.5;\n",
    "    else {\n",
    "        float q = e.aim.solid * surface.peak;\n",
    "        e.light_share = 8.0 / (8.0 + q * q * q);\n",
    "        e.light_share = floor(e.light_share * float(samples) + 0.5) / float(samples);\n",
    "    }\n",
    "    return e;\n",
    "}\n",
    "\n",
    "// f L cos / pdf of one sample; visibility and 1 / S are the caller's. u: cohsm_numbers.\n",
    "vec3 cohsm_estimate(cohsm_estimator e, vec3 u, out cohsm_emission found)\n",
    "{\n",
    "    float c = e.light_share;\n",
    "    bool by_light = u.x < c, hit;\n",
    "    vec3 wi;\n",
    "    u.x = cohsm_clamp_unit(by_light ? u.x / c : (u.x - c) / (1.0 - c));\n",
    "    if (by_light)\n",
    "        hit = cohsm_light_draw(e.light, e.aim, u, found);\n",
    "    else {\n",
    "        wi = cohsm_brdf_draw(e.surface, e.split ? 0.0 : e.surface.diffuse_share, u.xy);\n",
    "        hit = cohsm_light_hit(e.light, e.aim, cohsm_from_frame(e.surface, wi), found) && wi.z > 0.0;\n",
    "    }\n",
    "    if (!hit) {\n",
    "        found = cohsm_emission(e.surface.n, COHSM_INFINITY, vec3(0.0), vec3(0.0), 0.0);\n",
    "        return vec3(0.0);\n",
    "    }\n",
    "    wi = cohsm_to_frame(e.surface, found.direction);\n",
    "    cohsm_response r = cohsm_respond(e.surface, wi);\n",
    "    vec3 f = e.split ? (by_light ? r.diffuse : r.specular) : r.diffuse + r.specular;\n",
    "    float pdf = e.split ? (by_light ? c * found.pdf : (1.0 - c) * r.specular_pdf)\n",
    "                        : c * found.pdf + (1.0 - c) * cohsm_brdf_pdf(e.surface, r);\n",
    "    if (!(wi.z > 0.0) || !(pdf > 0.0)) return vec3(0.0);\n",
    "    f = f * found.radiance * (wi.z / pdf);\n",
    "    return cohsm_finite3(f) ? f : vec3(0.0);\n",
    "}\n"
};

static const char *const glbk__glsl_lib_cohsm_light_glsl[] = {
    "// cohsm_light - light functions A (what emits) and L (how much): samples of a light and hits of its surface.\n",
    "// C twins: cohsm_emitter_sample and cohsm_emitter_hit of csm.h. D, the place of maps, is in the blocks.\n",
    "//\n",
    "// COHSM_LIGHT_TEXEL(i): uvec4 texel i of the lights' texture, made by glbk_csm_light_write\n",
    "// (layout: docs/gpu-layouts.md).\n",
    "// uses: cohsm_math\n",
    "#ifndef COHSM_LIGHT_TEXEL\n",
    "#error \"cohsm_light.glsl needs COHSM_LIGHT_TEXEL(i), the uvec4 at texel i of the lights\"\n",
    "#endif\n",
    "\n",
    "#define COHSM_SHAPE_ENVIRONMENT 1u\n",
    "#define COHSM_SHAPE_SUN 2u\n",
    "#define COHSM_SHAPE_POINT 3u\n",
    "#define COHSM_SHAPE_SPOT 4u\n",
    "#define COHSM_SHAPE_LINE 5u\n",
    "#define COHSM_SHAPE_RECTANGLE 6u\n",
    "#define COHSM_SHAPE_DISC 7u\n",
    "#define COHSM_SHAPE_SPHERE 8u\n",
    "#define COHSM_SHAPE_MESH 10u    // a table of triangles: x picks one by area, y and z a point in it\n",
    "#define COHSM_INFINITY 3.402823466e38\n",
    "\n",
    "struct cohsm_light {\n",
    "    uint  base, shape, width, height, flags, texels_at, sums_at, triangles_at, triangle_count;\n",
    "    vec3  origin, n, ex, ey, u, v, radiance, tint;\n",
    "    float radius, lx, ly, area, cos_cone, turn, cosine_power;\n",
    "};\n",
    "\n",
    "struct cohsm_aim {              // a light as one point sees it\n",
    "    vec3  p, axis;\n",
    "    float range, spread, solid_pdf, solid;\n",
    "    vec4  edges;                // rectangle: x0 x1 y0 y1\n",
    "    vec4  cap;                  // rectangle: z b0 b1 k\n",
    "};\n",
    "\n",
    "struct cohsm_emission {\n",
    "    vec3  direction;\n",
    "    float range;                // COHSM_INFINITY for sky and sun\n",
    "    vec3  coords, radiance;\n",
    "    float pdf;\n",
    "};\n",
    "\n",
    "cohsm_light cohsm_light_open(uint base)\n",
    "{\n",
    "    cohsm_light l;\n",
    "    uvec4 a = COHSM_LIGHT_TEXEL(base), b = COHSM_LIGHT_TEXEL(base + 1u);\n",
    "    vec4 c = uintBitsToFloat(COHSM_LIGHT_TEXEL(base + 2u)), d = uintBitsToFloat(COHSM_LIGHT_TEXEL(base + 3u));\n",
    "    vec4 e = uintBitsToFloat(COHSM_LIGHT_TEXEL(base + 4u)), f = uintBitsToFloat(COHSM_LIGHT_TEXEL(base + 5u));\n",
    "    vec4 g = uintBitsToFloat(COHSM_LIGHT_TEXEL(base + 6u)), h = uintBitsToFloat(COHSM_LIGHT_TEXEL(base + 7u));\n",
    "    l.base = base;\n",
    "    l.shape = a.x;\n",
    "    l.width = a.y;\n",
    "    l.height = a.z;\n",
    "    l.flags = a.w;\n",
    "    l.texels_at = base + b.x;\n",
    "    l.sums_at = base + b.y;\n",
    "    l.triangles_at = base + b.z;\n",
    "    l.triangle_count = b.w;\n",
    "    l.origin = c.xyz;\n",
    "    l.radius = c.w;\n",
    "    l.n = d.xyz;\n",
    "    l.lx = d.w;\n",
    "    l.ex = e.xyz;\n",
    "    l.ly = e.w;\n",
    "    l.ey = f.xyz;\n",
    "    l.area = f.w;\n",
    "    l.radiance = g.xyz;\n",
    "    l.cos_cone = g.w;\n",
    "    l.tint = h.xyz;\n",
    "    l.turn = h.w;\n",
    "    c = uintBitsToFloat(COHSM_LIGHT_TEXEL(base + 8u));\n",
    "    l.u = c.xyz;\n",
    "    l.cosine_power = c.w;\n",
    "    l.v = uintBitsToFloat(COHSM_LIGHT_TEXEL(base + 9u)).xyz;\n",
    "    return l;\n",
    "}\n",
    "\n",
    "bool cohsm_light_textured(cohsm_light l) { return (l.flags & 1u) != 0u; }\n",
    "bool cohsm_light_is_delta(cohsm_light l) { return l.shape >= COHSM_SHAPE_SUN && l.shape <= COHSM_SHAPE_SPOT; }\n",
    "\n",
    "uint cohsm_index(float x, uint count) { return min(uint(x * float(count)), count - 1u); }\n",
    "\n",
    "vec3 cohsm_light_texel(cohsm_light l, uint x, uint y)\n",
    "{\n",
    "    return cohsm_light_textured(l) ? uintBitsToFloat(COHSM_LIGHT_TEXEL(l.texels_at + y * l.width + x)).xyz : vec3(1.0);\n",
    "}\n",
    "\n",
    "vec3 cohsm_texel_at(cohsm_light l, vec2 x)\n",
    "{\n",
    "    return cohsm_light_texel(l, cohsm_index(x.x, l.width), cohsm_index(x.y, l.height));\n",
    "}\n",
    "\n",
    "float cohsm_density(cohsm_light l, vec2 x) { return cohsm_light_textured(l) ? dot(cohsm_texel_at(l, x), l.tint) : 1.0; }\n",
    "\n",
    "// Inversion of the running sums at texel `at`: each holds the sum before its cell, the sum after it, and where\n",
    "// (as integers) the search begins and ends for numbers that fall into that fraction of 0..1.\n",
    "uint cohsm_invert(uint at, uint count, float u, out float fraction)\n",
    "{\n",
    "    uvec4 t = COHSM_LIGHT_TEXEL(at + cohsm_index(u, count));\n",
    "    uint lo = t.z, hi = t.w;\n",
    "    while (hi - lo > 1u) {\n",
    "        uint middle = lo + (hi - lo) / 2u;\n",
    "        if (uintBitsToFloat(COHSM_LIGHT_TEXEL(at + middle).x) <= u) lo = middle;\n",
    "        else hi = middle;\n",
    "    }\n",
    "    vec2 sums = uintBitsToFloat(COHSM_LIGHT_TEXEL(at + lo).xy);\n",
    "    while (lo + 1u < count && sums.y <= u) sums = uintBitsToFloat(COHSM_LIGHT_TEXEL(at + ++lo).xy);\n",
    "    while (lo > 0u && (sums.x > u || !(sums.y > sums.x))) sums = uintBitsToFloat(COHSM_LIGHT_TEXEL(at + --lo).xy);\n",
    "    fraction = cohsm_clamp_unit((u - sums.x) / (sums.y - sums.x));\n",
    "    return lo;\n",
    "}\n",
    "\n",
    "// The texel that u picks, and where inside.\n",
    "uvec2 cohsm_pick_cell(cohsm_light l, vec2 u, out vec2 inside)\n",
    "{\n",
    "    uint y = cohsm_invert(l.sums_at, l.height, u.y, inside.y);\n",
    "    uint x = cohsm_invert(l.sums_at + l.height + y * l.width, l.width, u.x, inside.x);\n",
    "    return uvec2(x, y);\n",
    "}\n",
    "\n",
    "vec2 cohsm_pick_coords(cohsm_light l, vec2 u)\n",
    "{\n",
    "    if (!cohsm_light_textured(l)) return u;\n",
    "    vec2 inside;\n",
    "    uvec2 cell = cohsm_pick_cell(l, u, inside);\n",
    "    return vec2(cohsm_clamp_unit((float(cell.x) + inside.x) / float(l.width)),\n",
    "                cohsm_clamp_unit((float(cell.y) + inside.y) / float(l.height)));\n",
    "}\n",
    "\n",
    "bool cohsm_emit(cohsm_light l, vec3 texel, float cosine, inout cohsm_emission e)\n",
    "{\n",
    "    e.radiance = l.radiance * texel;\n",
    "    if (l.cosine_power > 0.0) e.radiance *= cohsm_pow(cosine, l.cosine_power);\n",
    "    return cohsm_finite3(e.radiance) && e.radiance.x + e.radiance.y + e.radiance.z > 0.0;\n",
    "}\n",
    "\n",
    "// From the point q of the surface to what a.p sees of it.\n",
    "bool cohsm_emit_area(cohsm_light l, cohsm_aim a, vec3 q, vec3 n, vec2 x, float area_pdf, inout cohsm_emission e)\n",
    "{\n",
    "    vec3 d = q - a.p;\n",
    "    float square = dot(d, d), range = sqrt(square);\n",
    "    if (!(range > 0.0) || !cohsm_finite(square)) return false;\n",
    "    vec3 w = d * (1.0 / range);\n",
    "    float cosine = -dot(n, w);\n",
    "    if (!(cosine > 1e-7)) return false;\n",
    "    cosine = min(cosine, 1.0);\n",
    "    e.coords.xy = vec2(cohsm_clamp_unit(x.x), cohsm_clamp_unit(x.y));\n",
    "    e.range = range;\n",
    "    e.pdf = a.solid_pdf > 0.0 ? a.solid_pdf : area_pdf * square / cosine;\n",
    "    e.direction = w;\n",
    "    return cohsm_emit(l, cohsm_texel_at(l, x), cosine, e);\n",
    "}\n",
    "\n",
    "// ---- environment ----\n",
    "\n",
    "bool cohsm_environment_found(cohsm_light l, uvec2 cell, vec2 x, vec3 w, inout cohsm_emission e)\n",
    "{\n",
    "    vec3 texel = cohsm_light_texel(l, cell.x, cell.y);\n",
    "    x.x -= l.turn;\n",
    "    e.coords.xy = vec2(cohsm_clamp_unit(x.x - floor(x.x)), cohsm_clamp_unit(x.y));\n",
    "    e.range = COHSM_INFINITY;\n",
    "    e.pdf = dot(texel, l.tint);\n",
    "    e.direction = w;\n",
    "    return cohsm_emit(l, texel, 1.0, e) && e.pdf > 0.0;\n",
    "}\n",
    "\n",
    "// cos(pi y / h) to the last digits near the poles too.\n",
    "float cohsm_row_edge(uint y, uint h)\n",
    "{\n",
    "    uint m = min(y, h - y);\n",
    "    float s = cohsm_sincos(1.57079633 * float(m) / float(h)).x;\n",
    "    s = 1.0 - 2.0 * s * s;\n",
    "    return m == y ? s : -s;\n",
    "}\n",
    "\n",
    "bool cohsm_environment_draw(cohsm_light l, vec2 u, inout cohsm_emission e)\n",
    "{\n",
    "    vec2 inside;\n",
    "    uvec2 cell = cohsm_pick_cell(l, u, inside);\n",
    "    float x = (float(cell.x) + inside.x) / float(l.width), top = cohsm_row_edge(cell.y, l.height);\n",
    "    float y = top + (cohsm_row_edge(cell.y + 1u, l.height) - top) * inside.y;\n",
    "    float r = cohsm_safe_sqrt((1.0 - y) * (1.0 + y));\n",
    "    vec2 sc = cohsm_sincos(2.0 * COHSM_PI * (x - l.turn - 0.5));\n",
    "    return cohsm_environment_found(l, cell, vec2(x, cohsm_acos(y) / COHSM_PI), vec3(r * sc.y, y, r * sc.x), e);\n",
    "}\n",
    "\n",
    "bool cohsm_environment_hit(cohsm_light l, vec3 w, inout cohsm_emission e)\n",
    "{\n",
    "    vec2 x = vec2(0.5 + cohsm_atan2(w.z, w.x) / (2.0 * COHSM_PI) + l.turn, cohsm_acos(w.y) / COHSM_PI);\n",
    "    x.x -= floor(x.x);\n",
    "    return cohsm_environment_found(l, uvec2(cohsm_index(x.x, l.width), cohsm_index(x.y, l.height)), x, w, e);\n",
    "}\n",
    "\n",
    "// ---- what depends on the point alone ----\n",
    "\n",
    "// Rectangle by solid angle: Urena, Fajardo and King 2013, where the angle is not small.\n",
    "void cohsm_rectangle_aim(cohsm_light l, inout cohsm_aim a)\n",
    "{\n",
    "    vec3 d = l.origin - a.p;\n",
    "    float x0 = dot(d, l.ex) * l.lx, y0 = dot(d, l.ey) * l.ly, x1 = x0 + l.lx, y1 = y0 + l.ly, z = dot(d, l.n);\n",
    "    float z2 = z * z;\n",
    "    float n0 = -y0 / sqrt(z2 + y0 * y0), n1 = x1 / sqrt(z2 + x1 * x1);\n",
    "    float n2 = y1 / sqrt(z2 + y1 * y1), n3 = -x0 / sqrt(z2 + x0 * x0);\n",
    "    float k = 2.0 * COHSM_PI - cohsm_acos(-n2 * n3) - cohsm_acos(-n3 * n0);\n",
    "    a.edges = vec4(x0, x1, y0, y1);\n",
    "    a.cap = vec4(z, n0, n2, k);\n",
    "    a.solid = cohsm_acos(-n0 * n1) + cohsm_acos(-n1 * n2) - k;\n",
    "    if (a.solid > 0.05 && cohsm_finite(a.solid)) a.solid_pdf = 1.0 / a.solid;\n",
    "}\n",
    "\n",
    "float cohsm_flat_solid(vec3 n, vec3 d, float area)\n",
    "{\n",
    "    float d2 = dot(d, d), cosine = abs(dot(n, d)) / sqrt(d2 > 0.0 ? d2 : 1.0), near2 = area * (1.0 / (2.0 * COHSM_PI));\n",
    "    return area * (cosine * d2 + near2) / ((d2 + near2) * (d2 + near2));\n",
    "}\n",
    "\n",
    "vec2 cohsm_rectangle_pick(cohsm_aim a, vec2 u)\n",
    "{\n",
    "    float z = a.cap.x, b0 = a.cap.y;\n",
    "    vec2 sc = cohsm_sincos(u.x * a.solid + a.cap.w);\n",
    "    float f = (sc.y * b0 - a.cap.z) / sc.x, c = 1.0 / sqrt(f * f + b0 * b0);\n",
    "    c = clamp(f > 0.0 ? c : -c, -1.0, 1.0);\n",
    "    float x = clamp(-(c * z) / sqrt(max(1.0 - c * c, 1e-12)), a.edges.x, a.edges.y);\n",
    "    float d = sqrt(x * x + z * z), h0 = a.edges.z / sqrt(d * d + a.edges.z * a.edges.z);\n",
    "    float h1 = a.edges.w / sqrt(d * d + a.edges.w * a.edges.w), h = h0 + u.y * (h1 - h0);\n",
    "    float y = h * h < 1.0 - 1e-6 ? h * d / sqrt(1.0 - h * h) : a.edges.w;\n",
    "    return (vec2(x, y) - a.edges.xz) / (a.edges.yw - a.edges.xz);\n",
    "}\n",
    "\n",
    "// false: the light does not reach p.\n",
    "bool cohsm_aim_at(cohsm_light l, vec3 p, out cohsm_aim a)\n",
    "{\n",
    "    vec3 d = l.origin - p;\n",
    "    float r = l.radius;\n",
    "    a = cohsm_aim(p, vec3(0.0), 0.0, 0.0, 0.0, 0.0, vec4(0.0), vec4(0.0));\n",
    "    if (l.shape == COHSM_SHAPE_RECTANGLE) {\n",
    "        if (!(dot(l.n, d) < 0.0)) return false;\n",
    "        if ((l.flags & 2u) != 0u && !cohsm_light_textured(l)) cohsm_rectangle_aim(l, a);\n",
    "        if (!(a.solid_pdf > 0.0)) a.solid = cohsm_flat_solid(l.n, d + (l.u + l.v) * 0.5, l.area);\n",
    "        return true;\n",
    "    }\n",
    "    if (l.shape == COHSM_SHAPE_DISC) {\n",
    "        a.solid = cohsm_flat_solid(l.n, d, l.area);\n",
    "        return dot(l.n, d) < 0.0;\n",
    "    }\n",
    "    if (l.shape == COHSM_SHAPE_SPHERE) {\n",
    "        a.range = sqrt(dot(d, d));\n",
    "        if (!(a.range > r)) return false;\n",
    "        a.axis = d * (1.0 / a.range);\n",
    "        float s = (r / a.range) * (r / a.range);\n",
    "        a.spread = s / (1.0 + sqrt(1.0 - s));\n",
    "        a.solid = 2.0 * COHSM_PI * a.spread;\n",
    "        if (!cohsm_light_textured(l) && a.spread > 0.0) a.solid_pdf = 1.0 / a.solid;\n",
    "        return true;\n",
    "    }\n",
    "    if (l.shape == COHSM_SHAPE_LINE) {\n",
    "        float s = dot(d, l.n);\n",
    "        d = l.n * s - d;\n",
    "        a.range = sqrt(dot(d, d));\n",
    "        if (!(a.range > r)) return false;\n",
    "        a.axis = d * (1.0 / a.range);\n",
    "        a.spread = cohsm_safe_sqrt(1.0 - (r / a.range) * (r / a.range));\n",
    "        vec2 ends = vec2(s, s + l.lx);\n",
    "        ends /= sqrt(a.range * a.range + ends * ends);\n",
    "        a.solid = 2.0 * r / a.range * (ends.y - ends.x);\n",
    "    }\n",
    "    return true;\n",
    "}\n",
    "\n",
    "// ---- shapes ----\n",
    "\n",
    "bool cohsm_line_at(cohsm_light l, cohsm_aim a, float x, float sine, inout cohsm_emission e)\n",
    "{\n",
    "    float cosine = cohsm_safe_sqrt(1.0 - sine * sine);\n",
    "    vec3 n = a.axis * cosine + cross(l.n, a.axis) * sine;\n",
    "    vec3 q = (l.origin + l.n * (x * l.lx)) + n * l.radius;\n",
    "    return cohsm_emit_area(l, a, q, n, vec2(x, 0.0),\n",
    "                           cohsm_density(l, vec2(x, 0.0)) * cosine / (2.0 * a.spread * l.radius * l.lx), e);\n",
    "}\n",
    "\n",
    "bool cohsm_sphere_at(cohsm_light l, cohsm_aim a, vec3 n, inout cohsm_emission e)\n",
    "{\n",
    "    vec2 x = vec2(cohsm_clamp_unit(0.5 + cohsm_atan2(n.z, n.x) / (2.0 * COHSM_PI)),\n",
    "                  cohsm_clamp_unit(0.5 * (1.0 - n.y)));\n",
    "    return cohsm_emit_area(l, a, l.origin + n * l.radius, n, x, cohsm_density(l, x) / l.area, e);\n",
    "}\n",
    "\n",
    "bool cohsm_sphere_draw(cohsm_light l, cohsm_aim a, vec2 u, inout cohsm_emission e)\n",
    "{\n",
    "    if (!(a.solid_pdf > 0.0)) {\n",
    "        vec2 x = cohsm_pick_coords(l, u);\n",
    "        float y = 1.0 - 2.0 * x.y, ring = cohsm_safe_sqrt(1.0 - y * y);\n",
    "        vec2 sc = cohsm_sincos(2.0 * COHSM_PI * (x.x - 0.5));\n",
    "        return cohsm_sphere_at(l, a, cohsm_normalize(vec3(ring * sc.y, y, ring * sc.x) * l.radius), e);\n",
    "    }\n",
    "    // A cone about the axis; the normal where the ray meets the sphere follows from the law of sines.\n",
    "    float r = l.radius, c = u.x * a.spread, s2 = c * (2.0 - c);\n",
    "    c = 1.0 - c;\n",
    "    float reach = cohsm_safe_sqrt(r * r - a.range * a.range * s2), along = a.range * s2 + c * reach;\n",
    "    float x = cohsm_safe_sqrt(s2) * (a.range * c - reach) / r;\n",
    "    vec2 sc = cohsm_sincos(2.0 * COHSM_PI * u.y);\n",
    "    vec3 t, b;\n",
    "    cohsm_basis(a.axis, t, b);\n",
    "    return cohsm_sphere_at(l, a, cohsm_normalize(t * (x * sc.y) + b * (x * sc.x) + a.axis * (-along / r)), e);\n",
    "}\n",
    "\n",
    "bool cohsm_delta_draw(cohsm_light l, cohsm_aim a, inout cohsm_emission e)\n",
    "{\n",
    "    float scale = 1.0;\n",
    "    e.pdf = 1.0;\n",
    "    e.range = COHSM_INFINITY;\n",
    "    e.direction = l.n;\n",
    "    if (l.shape != COHSM_SHAPE_SUN) {\n",
    "        vec3 d = l.origin - a.p;\n",
    "        float range = sqrt(dot(d, d));\n",
    "        if (!(range > 0.0) || !cohsm_finite(range)) return false;\n",
    "        e.direction = d * (1.0 / range);\n",
    "        if (l.shape == COHSM_SHAPE_SPOT && -dot(e.direction, l.n) < l.cos_cone) return false;\n",
    "        scale = 1.0 / (range * range);\n",
    "        e.range = range;\n",
    "    }\n",
    "    return cohsm_emit(l, vec3(scale), 1.0, e);\n",
    "}\n",
    "\n",
    "// Triangles are three texels each: a corner and, in the first one's w, the share of all area up to the end of it.\n",
    "bool cohsm_mesh_draw(cohsm_light l, cohsm_aim a, vec3 u, inout cohsm_emission e)\n",
    "{\n",
    "    uint lo = 0u, hi = l.triangle_count - 1u;\n",
    "    while (lo < hi) {\n",
    "        uint middle = (lo + hi) / 2u;\n",
    "        if (uintBitsToFloat(COHSM_LIGHT_TEXEL(l.triangles_at + 3u * middle).w) <= u.x) lo = middle + 1u;\n",
    "        else hi = middle;\n",
    "    }\n",
    "    vec3 v0 = uintBitsToFloat(COHSM_LIGHT_TEXEL(l.triangles_at + 3u * lo).xyz);\n",
    "    vec3 v1 = uintBitsToFloat(COHSM_LIGHT_TEXEL(l.triangles_at + 3u * lo + 1u).xyz);\n",
    "    vec3 v2 = uintBitsToFloat(COHSM_LIGHT_TEXEL(l.triangles_at + 3u * lo + 2u).xyz);\n",
    "    float root = sqrt(u.y), c = root * u.z;\n",
    "    vec3 q = v0 * (1.0 - root) + v1 * (root * (1.0 - u.z)) + v2 * c;\n",
    "    e.coords.z = u.z;\n",
    "    return cohsm_emit_area(l, a, q, cohsm_normalize(cross(v1 - v0, v2 - v0)), u.xy, 1.0 / l.area, e);\n",
    "}\n",
    "\n",
    "// P_L: a point of the light in proportion to its texture. u in [0, 1); z serves meshes.\n",
    "bool cohsm_light_draw(cohsm_light l, cohsm_aim a, vec3 u, out cohsm_emission e)\n",
    "{\n",
    "    e = cohsm_emission(vec3(0.0), 0.0, vec3(0.0), vec3(0.0), 0.0);\n",
    "    if (l.shape == COHSM_SHAPE_ENVIRONMENT) return cohsm_environment_draw(l, u.xy, e);\n",
    "    if (cohsm_light_is_delta(l)) return cohsm_delta_draw(l, a, e);\n",
    "    if (l.shape == COHSM_SHAPE_SPHERE) return cohsm_sphere_draw(l, a, u.xy, e);\n",
    "    if (l.shape == COHSM_SHAPE_MESH) return cohsm_mesh_draw(l, a, u, e);\n",
    "    vec2 x = a.solid_pdf > 0.0 ? cohsm_rectangle_pick(a, u.xy) : cohsm_pick_coords(l, u.xy);\n",
    "    if (l.shape == COHSM_SHAPE_LINE) return cohsm_line_at(l, a, x.x, (2.0 * u.y - 1.0) * a.spread, e);\n",
    "    vec3 q;\n",
    "    if (l.shape == COHSM_SHAPE_DISC) {\n",
    "        vec2 p = cohsm_concentric(x);\n",
    "        q = l.origin + (l.ex * p.x + l.ey * p.y) * l.radius;\n",
    "    } else\n",
    "        q = l.origin + (l.u * x.x + l.v * x.y);\n",
    "    return cohsm_emit_area(l, a, q, l.n, x, cohsm_density(l, x) / l.area, e);\n",
    "}\n",
    "\n",
    "bool cohsm_plane_hit(cohsm_light l, cohsm_aim a, vec3 w, inout cohsm_emission e)\n",
    "{\n",
    "    vec3 d = a.p - l.origin;\n",
    "    float slope = -dot(l.n, w), height = dot(l.n, d);\n",
    "    if (!(slope > 1e-7) || !(height > 0.0)) return false;\n",
    "    d += w * (height / slope);\n",
    "    vec2 x = vec2(dot(d, l.ex), dot(d, l.ey));\n",
    "    if (l.shape == COHSM_SHAPE_DISC) {\n",
    "        x /= l.radius;\n",
    "        if (!(x.x * x.x + x.y * x.y < 1.0)) return false;\n",
    "        x = cohsm_disc_square(x);\n",
    "    } else if (!(x.x >= 0.0 && x.x < 1.0 && x.y >= 0.0 && x.y < 1.0))\n",
    "        return false;\n",
    "    return cohsm_emit_area(l, a, l.origin + d, l.n, x, cohsm_density(l, x) / l.area, e);\n",
    "}\n",
    "\n",
    "// Sphere and line: the nearer root, measured from the foot of the perpendicular.\n",
    "bool cohsm_round_hit(cohsm_light l, cohsm_aim a, vec3 w, inout cohsm_emission e)\n",
    "{\n",
    "    bool line = l.shape == COHSM_SHAPE_LINE;\n",
    "    vec3 d = line ? a.axis * -a.range : l.origin - a.p, v = line ? w - l.n * dot(w, l.n) : w;\n",
    "    float square = dot(v, v);\n",
    "    if (!(square > 1e-14)) return false;\n",
    "    float along = dot(d, v) / square;\n",
    "    vec3 n = v * along - d;\n",
    "    float s = l.radius * l.radius - dot(n, n);\n",
    "    if (!(along > 0.0) || !(s > 0.0)) return false;\n",
    "    s = sqrt(s / square);\n",
    "    n = (n - v * s) * (1.0 / l.radius);\n",
    "    if (!line) return cohsm_sphere_at(l, a, cohsm_normalize(n), e);\n",
    "    float x = dot((a.p - l.origin) + w * (along - s), l.n) / l.lx;\n",
    "    if (!(x >= 0.0 && x < 1.0)) return false;\n",
    "    return cohsm_line_at(l, a, x, dot(n, cross(l.n, a.axis)), e);\n",
    "}\n",
    "\n",
    "// What a ray from the aim's point sees of the light alone.\n",
    "bool cohsm_light_hit(cohsm_light l, cohsm_aim a, vec3 w, out cohsm_emission e)\n",
    "{\n",
    "    e = cohsm_emission(vec3(0.0), 0.0, vec3(0.0), vec3(0.0), 0.0);\n",
    "    if (l.shape == COHSM_SHAPE_ENVIRONMENT) return cohsm_environment_hit(l, w, e);\n",
    "    if (l.shape == COHSM_SHAPE_RECTANGLE || l.shape == COHSM_SHAPE_DISC) return cohsm_plane_hit(l, a, w, e);\n",
    "    if (l.shape == COHSM_SHAPE_SPHERE || l.shape == COHSM_SHAPE_LINE) return cohsm_round_hit(l, a, w, e);\n",
    "    return false;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_cohsm_lookup_glsl[] = {
    "// cohsm_lookup - one stored depth of a csm block (docs/csm-format.md), read from a texture of its words as they are.\n",
    "//\n",
    "// COHSM_TEXEL(i): the including program's uvec4 of words 4 i .. 4 i + 3; i (uint) counts through all blocks that were\n",
    "// uploaded. What a query needs of the header is read once by cohsm_open; keep the result.\n",
    "// COHSM_ONE_DOMAIN, COHSM_ONE_ORDER, COHSM_ONE_FRAME: the number that all blocks have there, where they agree; the code\n",
    "// for others is gone then.\n",
    "#ifndef COHSM_TEXEL\n",
    "#error \"cohsm_lookup.glsl needs COHSM_TEXEL(i), the uvec4 at texel i of the blocks\"\n",
    "#endif\n",
    "\n",
    "#define COHSM_DOMAIN_LATLONG 1u\n",
    "#define COHSM_DOMAIN_OCTAHEDRAL 2u\n",
    "#define COHSM_DOMAIN_DISC 5u\n",
    "#define COHSM_DOMAIN_SPHERE 6u\n",
    "#define COHSM_DOMAIN_TABLE 8u\n",
    "#define COHSM_DOMAIN_LIST 9u\n",
    "#define COHSM_ORDER_ZIGZAG 2u\n",
    "#define COHSM_ORDER_ZIGZAG_THETA 3u\n",
    "#define COHSM_ORDER_HILBERT 4u\n",
    "#define COHSM_FRAME_POLAR 1u\n",
    "#define COHSM_FRAME_MINIMAL 2u\n",
    "\n",
    "struct cohsm_maps {\n",
    "    uint  base;                     // texel of the first word\n",
    "    uint  domain, order, frame;\n",
    "    uvec3 side;\n",
    "    uint  map_count, map_size, depth_top, dimensions;\n",
    "    bool  positional;\n",
    "    uint  pixel_begin, pixel_end;\n",
    "    uint  order_at, locations_at, lookup_at, directories_at, lines_at;      // words from the first one\n",
    "    vec3  center;\n",
    "    float radius, depth_far;\n",
    "};\n",
    "\n",
    "// Of texels 1 to 7 of a block.\n",
    "cohsm_maps cohsm_unpack(uint base, uvec4 kinds, uvec4 sides, uvec4 sizes, uvec4 range, uvec4 lengths, uvec4 rest,\n",
    "                        uvec4 sphere)\n",
    "{\n",
    "    cohsm_maps m;\n",
    "    m.base = base;\n",
    "    m.domain = kinds.x;\n",
    "    m.order = kinds.z;\n",
    "    m.frame = kinds.w;\n",
    "    m.side = sides.xyz;\n",
    "    m.map_count = sides.w;\n",
    "    m.map_size = sizes.y;\n",
    "    m.depth_top = (1u << sizes.z) - 1u;\n",
    "    m.dimensions = sizes.w;\n",
    "    m.positional = range.x != 0u;\n",
    "    m.pixel_begin = range.z;\n",
    "    m.pixel_end = range.w;\n",
    "    m.order_at = 96u;\n",
    "    m.locations_at = m.order_at + lengths.x;\n",
    "    m.lookup_at = m.locations_at + lengths.y;\n",
    "    m.directories_at = m.lookup_at + lengths.z;\n",
    "    m.lines_at = m.directories_at + lengths.w;\n",
    "    m.center = vec3(uintBitsToFloat(rest.w), uintBitsToFloat(sphere.xy));\n",
    "    m.radius = uintBitsToFloat(sphere.z);\n",
    "    m.depth_far = uintBitsToFloat(sphere.w);\n",
    "#ifdef COHSM_ONE_DOMAIN\n",
    "    m.domain = uint(COHSM_ONE_DOMAIN);\n",
    "#if COHSM_ONE_DOMAIN < 8\n",
    "    m.positional = COHSM_ONE_DOMAIN > 2;\n",
    "    m.dimensions = COHSM_ONE_DOMAIN == 3 ? 1u : COHSM_ONE_DOMAIN == 7 ? 3u : 2u;\n",
    "#endif\n",
    "#endif\n",
    "#ifdef COHSM_ONE_ORDER\n",
    "    m.order = uint(COHSM_ONE_ORDER);\n",
    "#endif\n",
    "#ifdef COHSM_ONE_FRAME\n",
    "    m.frame = uint(COHSM_ONE_FRAME);\n",
    "#endif\n",
    "    return m;\n",
    "}\n",
    "\n",
    "cohsm_maps cohsm_open(uint base)\n",
    "{\n",
    "    return cohsm_unpack(base, COHSM_TEXEL(base + 1u), COHSM_TEXEL(base + 2u), COHSM_TEXEL(base + 3u),\n",
    "                        COHSM_TEXEL(base + 4u), COHSM_TEXEL(base + 5u), COHSM_TEXEL(base + 6u),\n",
    "                        COHSM_TEXEL(base + 7u));\n",
    "}\n",
    "\n",
    "uint cohsm_pick(uvec4 t, uint i)\n",
    "{\n",
    "    return (i & 2u) != 0u ? ((i & 1u) != 0u ? t.w : t.z) : ((i & 1u) != 0u ? t.y : t.x);\n",
    "}\n",
    "\n",
    "uint cohsm_word(cohsm_maps m, uint i) { return cohsm_pick(COHSM_TEXEL(m.base + (i >> 2)), i); }\n",
    "vec3 cohsm_floats(cohsm_maps m, uint i)\n",
    "{\n",
    "    return uintBitsToFloat(uvec3(cohsm_word(m, i), cohsm_word(m, i + 1u), cohsm_word(m, i + 2u)));\n",
    "}\n",
    "\n",
    "// Half word h of those that begin at word i.\n",
    "uint cohsm_half_word(cohsm_maps m, uint i, uint h)\n",
    "{\n",
    "    return (cohsm_word(m, i + (h >> 1)) >> (16u * (h & 1u))) & 0xffffu;\n",
    "}\n",
    "\n",
    "uint cohsm_popcount(uint x)\n",
    "{\n",
    "    x -= (x >> 1) & 0x55555555u;\n",
    "    x = (x & 0x33333333u) + ((x >> 2) & 0x33333333u);\n",
    "    x = (x + (x >> 4)) & 0x0f0f0f0fu;\n",
    "    return (x * 0x01010101u) >> 24;\n",
    "}\n",
    "\n",
    "// Position of the one with this number (from 0) in x; number < count of ones. Halving by counts of ever smaller parts.\n",
    "uint cohsm_select(uint x, uint number)\n",
    "{\n",
    "    uint two = x - ((x >> 1) & 0x55555555u);\n",
    "    uint four = (two & 0x33333333u) + ((two >> 2) & 0x33333333u);\n",
    "    uint eight = (four + (four >> 4)) & 0x0f0f0f0fu;\n",
    "    uint at = 0u, n = (eight + (eight >> 8)) & 0xffu;\n",
    "    if (number >= n) { number -= n; at = 16u; }\n",
    "    n = (eight >> at) & 15u;\n",
    "    if (number >= n) { number -= n; at += 8u; }\n",
    "    n = (four >> at) & 7u;\n",
    "    if (number >= n) { number -= n; at += 4u; }\n",
    "    n = (two >> at) & 3u;\n",
    "    if (number >= n) { number -= n; at += 2u; }\n",
    "    n = (x >> at) & 1u;\n",
    "    return number >= n ? at + 1u : at;\n",
    "}\n",
    "\n",
    "// The marks of a block: ones are segments, zeros ends of buckets.\n",
    "uvec2 cohsm_marks(uint w0, uint w1, uint w2) { return uvec2((w0 >> 16) | (w1 << 16), (w1 >> 16) | (w2 << 16)); }\n",
    "\n",
    "// Position after the zero with this number.\n",
    "uint cohsm_after_zero(uvec2 marks, uint number)\n",
    "{\n",
    "    uvec2 zeros = ~marks;\n",
    "    uint low = cohsm_popcount(zeros.x);\n",
    "    if (number < low) return cohsm_select(zeros.x, number) + 1u;\n",
    "    return cohsm_select(zeros.y, number - low) + 33u;\n",
    "}\n",
    "\n",
    "// 16-bit depth of a grid value; the last one and above are infinite.\n",
    "uint cohsm_grid_depth(cohsm_maps m, uint g) { return g >= m.depth_top ? 65535u : g * 65535u / m.depth_top; }\n",
    "\n",
    "// ---- lines: the 64 bytes that a block of segments lies in, fetched at once ----\n",
    "\n",
    "struct cohsm_line {\n",
    "    uvec4 a, b, c, d;\n",
    "    uint  bit;                      // of the block's first word\n",
    "};\n",
    "\n",
    "cohsm_line cohsm_fetch_line(cohsm_maps m, uint word)\n",
    "{\n",
    "    uint i = m.base + (word >> 4 << 2);\n",
    "    return cohsm_line(COHSM_TEXEL(i), COHSM_TEXEL(i + 1u), COHSM_TEXEL(i + 2u), COHSM_TEXEL(i + 3u),\n",
    "                      (word & 15u) << 5);\n",
    "}\n",
    "\n",
    "uint cohsm_line_word(cohsm_line l, uint i)\n",
    "{\n",
    "    return cohsm_pick((i & 8u) != 0u ? ((i & 4u) != 0u ? l.d : l.c) : ((i & 4u) != 0u ? l.b : l.a), i);\n",
    "}\n",
    "\n",
    "// count (1..32) bits of the block, from one of its bits on; with count 0, none.\n",
    "uint cohsm_bits(cohsm_line l, uint bit, uint count)\n",
    "{\n",
    "    bit += l.bit;\n",
    "    uint at = bit >> 5, shift = bit & 31u, x = cohsm_line_word(l, at) >> shift;\n",
    "    if (shift + count > 32u) x |= cohsm_line_word(l, at + 1u) << (32u - shift);\n",
    "    return count > 0u ? x & (0xffffffffu >> (32u - count)) : 0u;\n",
    "}\n",
    "\n",
    "// The segment of a block that holds a view, counted from the block's first.\n",
    "uint cohsm_segment(cohsm_line l, uint head, uvec2 marks, uint view)\n",
    "{\n",
    "    uint k = (head >> 8) & 15u, bucket = view >> k, low = view & ((1u << k) - 1u);\n",
    "    uint at = bucket > 0u ? cohsm_after_zero(marks, bucket - 1u) : 0u, j = at - bucket;\n",
    "    while (at < 64u && (((at < 32u ? marks.x : marks.y) >> (at & 31u)) & 1u) != 0u &&\n",
    "           cohsm_bits(l, 80u + j * k, k) <= low) {\n",
    "        at++;\n",
    "        j++;\n",
    "    }\n",
    "    return j - 1u;\n",
    "}\n",
    "\n",
    "// How many of the first count codes are all ones. As many as fit into a word are compared at once: one added to a code\n",
    "// without its highest bit carries into that bit where all others are set.\n",
    "uint cohsm_escapes(cohsm_line l, uint codes, uint bits, uint count)\n",
    "{\n",
    "    uint step = 32u / bits, one = (0xffffffffu >> (32u - step * bits)) / ((1u << bits) - 1u), high = one << (bits - 1u);\n",
    "    uint rank = 0u;\n",
    "    for (uint i = 0u; i < count; i += step) {\n",
    "        uint x = cohsm_bits(l, codes + i * bits, min(step, count - i) * bits);\n",
    "        rank += cohsm_popcount(((x & ~high) + one) & x & high);\n",
    "    }\n",
    "    return rank;\n",
    "}\n",
    "\n",
    "// Depth of segment j of a block.\n",
    "uint cohsm_segment_depth(cohsm_maps m, cohsm_line l, uint head, uvec2 marks, uint j)\n",
    "{\n",
    "    uint n = cohsm_popcount(marks.x) + cohsm_popcount(marks.y), k = (head >> 8) & 15u, bits = (head >> 12) & 15u;\n",
    "    uint base = head & 255u, codes = 80u + n * k;\n",
    "    bool palette = bits > 9u;\n",
    "    if (palette) bits -= 9u;\n",
    "    uint code = cohsm_bits(l, codes + j * bits, bits), ones = (1u << bits) - 1u;\n",
    "    if (code == ones) {\n",
    "        uint rank = cohsm_escapes(l, codes, max(bits, 1u), min(j, 64u));\n",
    "        return cohsm_bits(l, codes + n * bits + (palette ? 8u * base : 0u) + 16u * rank, 16u);\n",
    "    }\n",
    "    if (palette) return cohsm_grid_depth(m, cohsm_bits(l, codes + n * bits + 8u * code, 8u));\n",
    "    return code + 1u == ones ? 65535u : cohsm_grid_depth(m, base + code);\n",
    "}\n",
    "\n",
    "// The block of a list that holds a view: its number, and its first view.\n",
    "uvec2 cohsm_find_block(cohsm_maps m, uint list, uint count, uint view)\n",
    "{\n",
    "    uint from = 2u * list + 4u, low = from >> 3, high = (from + count + 6u) >> 3;   // eight first views a texel\n",
    "    uvec2 found = uvec2(0u);\n",
    "    while (low < high) {\n",
    "        uint middle = (low + high) >> 1, i = 8u * middle - from;\n",
    "        uvec4 t = COHSM_TEXEL(m.base + middle), even = t & 0xffffu, odd = t >> 16;\n",
    "        uvec4 number = i + uvec4(0u, 2u, 4u, 6u), top = uvec4(count - 1u), asked = uvec4(view);\n",
    "        even = (even + 1u) * uvec4(lessThan(number, top)) * uvec4(lessThanEqual(even, asked));\n",
    "        odd = (odd + 1u) * uvec4(lessThan(number + 1u, top)) * uvec4(lessThanEqual(odd, asked));\n",
    "        uvec4 last = max(even, odd), ones = min(even, 1u) + min(odd, 1u);\n",
    "        uint first = max(max(last.x, last.y), max(last.z, last.w));     // + 1, or 0: none begins before\n",
    "        if (first > 0u) {\n",
    "            found = uvec2((8u * middle < from ? 0u : i) + ones.x + ones.y + ones.z + ones.w, first - 1u);\n",
    "            low = middle + 1u;\n",
    "        } else\n",
    "            high = middle;\n",
    "    }\n",
    "    return found;\n",
    "}\n",
    "\n",
    "// Stored 16-bit depth of a pixel (less pixel_begin) in the view with this place in the sequence.\n",
    "// C twin: cohsm__stored_depth, public as cohsm_depths.\n",
    "uint cohsm_stored_depth(cohsm_maps m, uint pixel, uint place)\n",
    "{\n",
    "    uint entry = cohsm_word(m, m.lookup_at + (place >> 16) * (m.pixel_end - m.pixel_begin) + pixel);\n",
    "    if ((entry & 0x80000000u) != 0u) return entry & 0xffffu;\n",
    "    uint list = m.directories_at + entry, view = place & 0xffffu;\n",
    "    uvec4 t = COHSM_TEXEL(m.base + (list >> 2));\n",
    "    uint first = cohsm_pick(t, list);\n",
    "    uint count = (list & 3u) == 3u ? COHSM_TEXEL(m.base + (list >> 2) + 1u).x : cohsm_pick(t, list + 1u);\n",
    "    uint tail = count >> 16;\n",
    "    count &= 0xffffu;\n",
    "    uvec2 block = cohsm_find_block(m, list, count, view);\n",
    "    uint line = block.x + 1u < count ? 16u * (first + block.x) : 16u * (first - (tail >> 4)) + (tail & 15u);\n",
    "    cohsm_line l = cohsm_fetch_line(m, m.lines_at + line);\n",
    "    uint at = l.bit >> 5, head = cohsm_line_word(l, at);\n",
    "    uvec2 marks = cohsm_marks(head, cohsm_line_word(l, at + 1u), cohsm_line_word(l, at + 2u));\n",
    "    return cohsm_segment_depth(m, l, head, marks, cohsm_segment(l, head, marks, view - block.y));\n",
    "}\n"
};

static const char *const glbk__glsl_lib_cohsm_math_glsl[] = {
    "// cohsm_math - elementary functions and random numbers with the answers of csm.h. Needs nothing.\n",
    "//\n",
    "// The polynomials are those of csm.h (units trig, octa, v3, rng and lds), since the built-in acos and atan of drivers\n",
    "// are off by up to 1e-4, which would ask another map. C twins: cohsm__sincos and so on, private to csm.h.\n",
    "\n",
    "#define COHSM_PI 3.14159265\n",
    "#define COHSM_BELOW_1 0.99999994\n",
    "#define COHSM_HUGE 3.402823466e38\n",
    "\n",
    "bool cohsm_finite(float x) { return (floatBitsToUint(x) & 0x7f800000u) != 0x7f800000u; }\n",
    "bool cohsm_finite3(vec3 v) { return cohsm_finite(v.x) && cohsm_finite(v.y) && cohsm_finite(v.z); }\n",
    "float cohsm_clamp_unit(float u) { return u > 0.0 ? min(u, COHSM_BELOW_1) : 0.0; }\n",
    "float cohsm_safe_sqrt(float x) { return x > 0.0 ? sqrt(x) : 0.0; }\n",
    "\n",
    "// |x| with the sign bit of s; s = -0 counts as negative.\n",
    "float cohsm_copysign(float x, float s)\n",
    "{\n",
    "    return uintBitsToFloat((floatBitsToUint(x) & 0x7fffffffu) | (floatBitsToUint(s) & 0x80000000u));\n",
    "}\n",
    "\n",
    "// (sine, cosine); |x| <= 8192, 1e-7 absolute.\n",
    "vec2 cohsm_sincos(float x)\n",
    "{\n",
    "    float t = clamp(x, -8192.0, 8192.0);\n",
    "    int k = int(t * 0.636619772 + (t < 0.0 ? -0.5 : 0.5));\n",
    "    float q = float(k);\n",
    "    float r = ((t - q * 1.5703125) - q * 4.837512969970703125e-4) - q * 7.5497899548918822e-8;\n",
    "    float z = r * r;\n",
    "    float s = r + r * z * (-0.1666665494 + z * (0.008332178146 + z * -0.0001951729898));\n",
    "    float c = (1.0 - 0.5 * z) + z * z * (0.04166664687 + z * (-0.001388736752 + z * 2.443845159e-5));\n",
    "    vec2 v = (k & 1) != 0 ? vec2(c, s) : vec2(s, c);\n",
    "    return vec2((k & 2) != 0 ? -v.x : v.x, ((k + 1) & 2) != 0 ? -v.y : v.y);\n",
    "}\n",
    "\n",
    "float cohsm_acos(float x)\n",
    "{\n",
    "    float a = min(abs(x), 1.0), h = 0.5 * (1.0 - a);\n",
    "    bool far = a > 0.5;\n",
    "    float s = far ? sqrt(h) : a, z = far ? h : a * a;\n",
    "    float p = s + s * z * (0.1666675393 + z * (0.07495241769 + z * (0.04547709903 + z * (0.02414760004 +\n",
    "              z * 0.04221856856))));\n",
    "    p = far ? 2.0 * p : 1.57079633 - p;\n",
    "    return x < 0.0 ? 3.14159265 - p : p;\n",
    "}\n",
    "\n",
    "// All quadrants and zeros of either sign; atan2(0, 0) = 0.\n",
    "float cohsm_atan2(float y, float x)\n",
    "{\n",
    "    float ax = abs(x), ay = abs(y), hi = max(ax, ay), lo = min(ax, ay);\n",
    "    float a = lo == hi && hi > 0.0 ? 1.0 : lo / (hi > 0.0 ? hi : 1.0);\n",
    "    bool steep = a > 0.414213562;\n",
    "    float t = steep ? (a - 1.0) / (a + 1.0) : a, z = t * t;\n",
    "    float p = t + t * z * (-0.3333295525 + z * (0.1997792608 + z * (-0.1387984996 + z * 0.08060308882)));\n",
    "    p = steep ? p + 0.785398163 : p;\n",
    "    p = ay > ax ? 1.57079633 - p : p;\n",
    "    p = (floatBitsToUint(x) >> 31) != 0u ? 3.14159265 - p : p;\n",
    "    return cohsm_copysign(p, y);\n",
    "}\n",
    "\n",
    "// exp(x), x at most 88; 0 below -87. In float, with ln 2 in two parts.\n",
    "float cohsm_exp(float x)\n",
    "{\n",
    "    float t = clamp(x, -88.0, 88.0);\n",
    "    float k = floor(t * 1.44269504 + 0.5);\n",
    "    float r = (t - k * 0.693145752) - k * 1.42860677e-6;\n",
    "    float p = 1.0 + (r + r * r * (0.500000008 + r * (0.166666669 + r * (0.0416662701 + r * (0.00833326438 +\n",
    "              r * 0.00139460621)))));\n",
    "    return t < -87.0 ? 0.0 : p * uintBitsToFloat(uint(int(k) + 127) << 23);\n",
    "}\n",
    "\n",
    "// x > 0 and normal: x = 2^e m with m in [sqrt(1/2), sqrt(2)), log m = 2 artanh((m - 1) / (m + 1)): exact digits near 1.\n",
    "float cohsm_log(float x)\n",
    "{\n",
    "    uint bits = floatBitsToUint(x);\n",
    "    int e = int(bits >> 23) - 127;\n",
    "    float m = uintBitsToFloat((bits & 0x007fffffu) | 0x3f800000u);\n",
    "    if (m > 1.41421356) {\n",
    "        m *= 0.5;\n",
    "        e += 1;\n",
    "    }\n",
    "    float s = (m - 1.0) / (m + 1.0), z = s * s;\n",
    "    float p = 2.0 * (s + s * z * (0.333333328 + z * (0.200001676 + z * (0.142686543 + z * 0.117910756))));\n",
    "    return float(e) * 0.693145752 + (p + float(e) * 1.42860677e-6);\n",
    "}\n",
    "\n",
    "// x below 0 counts as 0. The result is relative to 1e-7 times the size of y log x.\n",
    "float cohsm_pow(float x, float y)\n",
    "{\n",
    "    if (y == 0.0) return 1.0;\n",
    "    if (!(x > 1.18e-38)) return y > 0.0 ? 0.0 : COHSM_HUGE;\n",
    "    float t = y * cohsm_log(x);\n",
    "    return t > 88.0 ? COHSM_HUGE : cohsm_exp(t);\n",
    "}\n",
    "\n",
    "// Unit vector, safe for tiny and huge ones; zero stays zero.\n",
    "vec3 cohsm_normalize(vec3 v)\n",
    "{\n",
    "    float m = max(max(abs(v.x), abs(v.y)), abs(v.z));\n",
    "    if (!(m > 0.0)) return vec3(0.0);\n",
    "    if (m < 1e-30) {\n",
    "        v *= 1e30;\n",
    "        m *= 1e30;\n",
    "    }\n",
    "    v /= m;\n",
    "    return v / sqrt(dot(v, v));\n",
    "}\n",
    "\n",
    "// t, b, n right-handed and orthonormal for a unit n.\n",
    "void cohsm_basis(vec3 n, out vec3 t, out vec3 b)\n",
    "{\n",
    "    float s = n.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (s + n.z), c = n.x * n.y * a;\n",
    "    t = vec3(1.0 + s * n.x * n.x * a, s * c, -s * n.x);\n",
    "    b = vec3(c, s + n.y * n.y * a, -n.y);\n",
    "}\n",
    "\n",
    "// Equal-area map between the unit square and the sphere, +Y in the middle (Clarberg 2008).\n",
    "vec3 cohsm_octa_direction(vec2 uv)\n",
    "{\n",
    "    float a = 2.0 * uv.x - 1.0, b = 2.0 * uv.y - 1.0, x = abs(a), z = abs(b);\n",
    "    float d = 1.0 - (x + z), r = 1.0 - abs(d), f = r * sqrt(2.0 - r * r);\n",
    "    vec2 sc = cohsm_sincos(r > 0.0 ? ((z - x) / r + 1.0) * 0.785398163 : 0.0);\n",
    "    return vec3(a < 0.0 ? -f * sc.y : f * sc.y, d < 0.0 ? r * r - 1.0 : 1.0 - r * r, b < 0.0 ? -f * sc.x : f * sc.x);\n",
    "}\n",
    "\n",
    "vec2 cohsm_octa_square(vec3 n)\n",
    "{\n",
    "    float r = sqrt((n.x * n.x + n.z * n.z) / (1.0 + abs(n.y)));\n",
    "    float b = cohsm_atan2(abs(n.z), abs(n.x)) * 0.636619772 * r, a = r - b, t = a;\n",
    "    if (n.y < 0.0) {\n",
    "        a = 1.0 - b;\n",
    "        b = 1.0 - t;\n",
    "    }\n",
    "    a = clamp(a, 0.0, 1.0);\n",
    "    b = clamp(b, 0.0, 1.0);\n",
    "    return 0.5 * vec2(n.x < 0.0 ? 1.0 - a : 1.0 + a, n.z < 0.0 ? 1.0 - b : 1.0 + b);\n",
    "}\n",
    "\n",
    "// Shirley and Chiu's concentric map of the unit square to the unit disc.\n",
    "vec2 cohsm_concentric(vec2 uv)\n",
    "{\n",
    "    float a = 2.0 * uv.x - 1.0, b = 2.0 * uv.y - 1.0, r, phi;\n",
    "    if (abs(a) > abs(b)) {\n",
    "        r = a;\n",
    "        phi = 0.785398163 * (b / a);\n",
    "    } else {\n",
    "        r = b;\n",
    "        phi = b == 0.0 ? 0.0 : 1.57079633 - 0.785398163 * (a / b);\n",
    "    }\n",
    "    return r * cohsm_sincos(phi).yx;\n",
    "}\n",
    "\n",
    "// Its inverse.\n",
    "vec2 cohsm_disc_square(vec2 p)\n",
    "{\n",
    "    float r = sqrt(p.x * p.x + p.y * p.y), a, b;\n",
    "    if (abs(p.x) > abs(p.y)) {\n",
    "        a = p.x > 0.0 ? r : -r;\n",
    "        b = a * (4.0 / COHSM_PI) * cohsm_atan2(p.y / p.x, 1.0);\n",
    "    } else {\n",
    "        b = p.y > 0.0 ? r : -r;\n",
    "        a = r > 0.0 ? b * (4.0 / COHSM_PI) * cohsm_atan2(p.x / p.y, 1.0) : 0.0;\n",
    "    }\n",
    "    return vec2(cohsm_clamp_unit(0.5 * (a + 1.0)), cohsm_clamp_unit(0.5 * (b + 1.0)));\n",
    "}\n",
    "\n",
    "// ---- random numbers: counter-based, the same on every machine ----\n",
    "\n",
    "uint cohsm_hash(uint x)\n",
    "{\n",
    "    uint state = x * 747796405u + 2891336453u;\n",
    "    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;\n",
    "    return (word >> 22) ^ word;\n",
    "}\n",
    "\n",
    "uint cohsm_hash_combine(uint a, uint b) { return cohsm_hash(a + 0x9e3779b9u * cohsm_hash(b)); }\n",
    "float cohsm_to_unit(uint bits) { return float(bits >> 8) * (1.0 / 16777216.0); }\n",
    "\n",
    "// Number i of a stream, in [0, 1).\n",
    "float cohsm_random(uint seed, uint stream, uint i)\n",
    "{\n",
    "    return cohsm_to_unit(cohsm_hash_combine(cohsm_hash_combine(seed, stream), i));\n",
    "}\n",
    "\n",
    "uint cohsm_reverse_bits(uint x)\n",
    "{\n",
    "    x = (x >> 16) | (x << 16);\n",
    "    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);\n",
    "    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);\n",
    "    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);\n",
    "    return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);\n",
    "}\n",
    "\n",
    "// Owen scrambling by hash (Laine and Karras, constants of Burley 2020).\n",
    "uint cohsm_owen(uint x, uint seed)\n",
    "{\n",
    "    x = cohsm_reverse_bits(x) + seed;\n",
    "    x ^= x * 0x6c50b47cu;\n",
    "    x ^= x * 0xb82f1e52u;\n",
    "    x ^= x * 0xc7afe638u;\n",
    "    x ^= x * 0x8d22f6e6u;\n",
    "    return cohsm_reverse_bits(x);\n",
    "}\n",
    "\n",
    "// Point i of a scrambled (0, 2)-sequence.\n",
    "vec2 cohsm_sobol2(uint i, uint seed)\n",
    "{\n",
    "    uint y = 0u, d = 0x80000000u;\n",
    "    i = cohsm_owen(i, cohsm_hash(seed));\n",
    "    uint x = cohsm_reverse_bits(i);\n",
    "    for (uint k = i; k != 0u; k >>= 1) {\n",
    "        if ((k & 1u) != 0u) y ^= d;\n",
    "        d ^= d >> 1;\n",
    "    }\n",
    "    return vec2(cohsm_to_unit(cohsm_owen(x, cohsm_hash_combine(seed, 1u))),\n",
    "                cohsm_to_unit(cohsm_owen(y, cohsm_hash_combine(seed, 2u))));\n",
    "}\n"
};

static const char *const glbk__glsl_lib_cohsm_visible_glsl[] = {
    "// cohsm_visible - is a point lit: distant, local and semi-local light, all filters, one object or a scene of\n",
    "// instances, receivers. Needs what cohsm_lookup.glsl needs. C twins: cohsm_visible and\n",
    "// cohsm_visible_scene of csm.h, for one sample.\n",
    "//\n",
    "//     cohsm_maps maps = cohsm_open(0u);\n",
    "//     float lit = cohsm_visible(maps, cohsm_ask(COHSM_LIGHT_DIRECTION, COHSM_FILTER_PCF, 1.0), point, direction);\n",
    "// uses: cohsm_math cohsm_lookup\n",
    "\n",
    "#define COHSM_LIGHT_DIRECTION 0     // light: the unit direction to it; maps of directions\n",
    "#define COHSM_LIGHT_POSITION 1      // light: a position outside the hulls, in the space of the point\n",
    "#define COHSM_LIGHT_PARAMETER 2     // light: coordinates in 0..1 of the maps' domain\n",
    "#define COHSM_LIGHT_INDEX 3         // light.x: uintBitsToFloat(cell)\n",
    "#define COHSM_FILTER_NEAREST 0\n",
    "#define COHSM_FILTER_PCF 1          // 2^d maps x 4 pixels\n",
    "#define COHSM_FILTER_ROULETTE 2     // one of them at random\n",
    "#define COHSM_REFUSED (-1.0)        // the light lies inside an object's hull\n",
    "#define COHSM_NO_SELF 0xffffffffu   // the point lies on no instance\n",
    "#define COHSM_NO_PIXEL 0xffffffffu  // beside the map: lit\n",
    "\n",
    "struct cohsm_query {\n",
    "    int   light, filtering;\n",
    "    float bias;                     // map pixels\n",
    "    uint  seed, id;                 // of roulette; id: number of the sample\n",
    "};\n",
    "\n",
    "cohsm_query cohsm_ask(int light, int filtering, float bias) { return cohsm_query(light, filtering, bias, 0u, 0u); }\n",
    "\n",
    "// ---- domains ----\n",
    "\n",
    "vec3 cohsm_affine(cohsm_maps m, float s, float t, float r)\n",
    "{\n",
    "    return ((cohsm_floats(m, 33u) + cohsm_floats(m, 36u) * s) + cohsm_floats(m, 39u) * t) + cohsm_floats(m, 42u) * r;\n",
    "}\n",
    "\n",
    "// D at coordinates s: a unit direction or a position.\n",
    "vec3 cohsm_map_parameter(cohsm_maps m, vec3 s)\n",
    "{\n",
    "    if (m.domain == COHSM_DOMAIN_OCTAHEDRAL) return cohsm_octa_direction(s.xy);\n",
    "    if (m.domain == COHSM_DOMAIN_LATLONG || m.domain == COHSM_DOMAIN_SPHERE) {\n",
    "        vec2 around = cohsm_sincos((s.x - 0.5) * 6.28318531);\n",
    "        if (m.domain == COHSM_DOMAIN_LATLONG) {\n",
    "            vec2 down = cohsm_sincos(s.y * 3.14159265);\n",
    "            return vec3(down.x * around.y, down.y, down.x * around.x);\n",
    "        }\n",
    "        float y = 1.0 - 2.0 * s.y, ring = y >= 1.0 || y <= -1.0 ? 0.0 : sqrt(1.0 - y * y);\n",
    "        vec3 u = cohsm_floats(m, 36u);\n",
    "        return cohsm_floats(m, 33u) + vec3(ring * around.y, y, ring * around.x) * sqrt(dot(u, u));\n",
    "    }\n",
    "    if (m.domain == COHSM_DOMAIN_DISC) {\n",
    "        vec2 p = cohsm_concentric(s.xy);\n",
    "        return cohsm_affine(m, p.x, p.y, 0.0);\n",
    "    }\n",
    "    return cohsm_affine(m, s.x, s.y, s.z);\n",
    "}\n",
    "\n",
    "uint cohsm_cell(cohsm_maps m, uvec3 c) { return c.x + m.side.x * (c.y + m.side.y * c.z); }\n",
    "\n",
    "uvec3 cohsm_cell_split(cohsm_maps m, uint cell)\n",
    "{\n",
    "    return uvec3(cell % m.side.x, cell / m.side.x % m.side.y, cell / (m.side.x * m.side.y));\n",
    "}\n",
    "\n",
    "vec3 cohsm_cell_location(cohsm_maps m, uvec3 c)\n",
    "{\n",
    "    if (m.domain >= COHSM_DOMAIN_TABLE) return cohsm_floats(m, m.locations_at + 4u * cohsm_cell(m, c));\n",
    "    return cohsm_map_parameter(m, (vec3(c) + 0.5) / vec3(m.side));\n",
    "}\n",
    "\n",
    "// Right and up of a direction's map.\n",
    "void cohsm_frame(cohsm_maps m, uvec3 c, out vec3 right, out vec3 up, out vec3 back)\n",
    "{\n",
    "    back = cohsm_cell_location(m, c);\n",
    "    if (m.frame == COHSM_FRAME_POLAR && m.domain == COHSM_DOMAIN_LATLONG) {\n",
    "        vec2 around = cohsm_sincos(((float(c.x) + 0.5) / float(m.side.x) - 0.5) * 6.28318531);\n",
    "        vec2 down = cohsm_sincos((float(c.y) + 0.5) / float(m.side.y) * 3.14159265);\n",
    "        right = vec3(-around.x, 0.0, around.y);\n",
    "        up = vec3(-down.y * around.y, down.x, -down.y * around.x);\n",
    "        return;\n",
    "    }\n",
    "    if (m.frame == COHSM_FRAME_POLAR) {\n",
    "        float h = sqrt(back.x * back.x + back.z * back.z);\n",
    "        right = h > 1e-6 ? vec3(-back.z / h, 0.0, back.x / h) : vec3(0.0, 0.0, 1.0);\n",
    "        up = cross(right, back);\n",
    "        return;\n",
    "    }\n",
    "    float s = m.frame == COHSM_FRAME_MINIMAL || back.y >= 0.0 ? 1.0 : -1.0;\n",
    "    if (abs(s + back.y) < 1e-6) {\n",
    "        right = vec3(1.0, 0.0, 0.0);\n",
    "        up = vec3(0.0, 0.0, 1.0);\n",
    "        return;\n",
    "    }\n",
    "    float a = -1.0 / (s + back.y);\n",
    "    right = vec3(1.0 + s * back.x * back.x * a, -s * back.x, s * back.x * back.z * a);\n",
    "    up = vec3(back.x * back.z * a, -back.z, s + back.z * back.z * a);\n",
    "}\n",
    "\n",
    "// Continuous position in the domain, cell centres at whole numbers.\n",
    "vec3 cohsm_domain_position(cohsm_maps m, vec3 light, int kind)\n",
    "{\n",
    "    vec3 u = light, top = vec3(m.side);\n",
    "    if (kind == COHSM_LIGHT_DIRECTION || kind == COHSM_LIGHT_POSITION) {\n",
    "        if (m.domain == COHSM_DOMAIN_LATLONG) {\n",
    "            u.x = 0.5 + cohsm_atan2(light.z, light.x) * 0.159154943;\n",
    "            u.y = cohsm_acos(light.y / sqrt(dot(light, light))) * 0.318309886;\n",
    "        } else\n",
    "            u.xy = cohsm_octa_square(cohsm_normalize(light));\n",
    "    }\n",
    "    u = clamp(u * top, vec3(0.0), top);\n",
    "    return vec3(m.dimensions > 0u ? u.x : 0.0, m.dimensions > 1u ? u.y : 0.0, m.dimensions > 2u ? u.z : 0.0) - 0.5;\n",
    "}\n",
    "\n",
    "// Brings a cell one step outside back: round the seam, over a pole, across the octahedral square's edge, to the border.\n",
    "uvec3 cohsm_wrap(cohsm_maps m, ivec3 c)\n",
    "{\n",
    "    ivec3 n = ivec3(m.side);\n",
    "    if (m.domain == COHSM_DOMAIN_LATLONG || m.domain == COHSM_DOMAIN_SPHERE) {\n",
    "        if (c.y < 0 || c.y >= n.y) c.x += n.x / 2;\n",
    "        if (c.x < 0) c.x += n.x;\n",
    "        if (c.x >= n.x) c.x -= n.x;\n",
    "        if (c.x >= n.x) c.x -= n.x;\n",
    "    } else if (m.domain == COHSM_DOMAIN_OCTAHEDRAL) {\n",
    "        if (c.x < 0 || c.x >= n.x) c.y = n.y - 1 - c.y;\n",
    "        else if (c.y < 0 || c.y >= n.y) c.x = n.x - 1 - c.x;\n",
    "    }\n",
    "    return uvec3(clamp(c, ivec3(0), n - 1));\n",
    "}\n",
    "\n",
    "// Place of a cell in the sequence of maps.\n",
    "uint cohsm_place(cohsm_maps m, uvec3 c)\n",
    "{\n",
    "    if (m.order == COHSM_ORDER_ZIGZAG) {\n",
    "        uint line = ((c.z & 1u) != 0u ? m.side.y - 1u - c.y : c.y) + m.side.y * c.z;\n",
    "        return line * m.side.x + ((line & 1u) != 0u ? m.side.x - 1u - c.x : c.x);\n",
    "    }\n",
    "    if (m.order == COHSM_ORDER_ZIGZAG_THETA) {\n",
    "        uint line = ((c.z & 1u) != 0u ? m.side.x - 1u - c.x : c.x) + m.side.x * c.z;\n",
    "        return line * m.side.y + ((line & 1u) != 0u ? m.side.y - 1u - c.y : c.y);\n",
    "    }\n",
    "    uint cell = cohsm_cell(m, c);\n",
    "    if (m.order != COHSM_ORDER_HILBERT) return cell;\n",
    "    return m.map_count <= 65536u ? cohsm_half_word(m, m.order_at, cell) : cohsm_word(m, m.order_at + cell);\n",
    "}\n",
    "\n",
    "// ---- one map ----\n",
    "\n",
    "// Coordinates of a cube's face: along the axis, then the two next ones.\n",
    "vec3 cohsm_face_coordinates(vec3 q, out uint face)\n",
    "{\n",
    "    vec3 a = abs(q);\n",
    "    if (a.x >= a.y && a.x >= a.z) {\n",
    "        face = q.x < 0.0 ? 1u : 0u;\n",
    "        return vec3(a.x, q.y, q.z);\n",
    "    }\n",
    "    if (a.y >= a.z) {\n",
    "        face = q.y < 0.0 ? 3u : 2u;\n",
    "        return vec3(a.y, q.z, q.x);\n",
    "    }\n",
    "    face = q.z < 0.0 ? 5u : 4u;\n",
    "    return vec3(a.z, q.x, q.y);\n",
    "}\n",
    "\n",
    "// Point p, in radii about the centre, in the map of a cell: pixels, and depth in 16 bits.\n",
    "vec3 cohsm_see(cohsm_maps m, uvec3 c, vec3 p, float bias, out uint face)\n",
    "{\n",
    "    float size = float(m.map_size), middle = 0.5 * size;\n",
    "    face = 0u;\n",
    "    if (!m.positional) {\n",
    "        vec3 right, up, back;\n",
    "        cohsm_frame(m, c, right, up, back);\n",
    "        return vec3(dot(p, right) * middle + middle, dot(p, up) * middle + middle,\n",
    "                    (0.5 - 0.5 * dot(p, back) - bias / size) * 65533.0);\n",
    "    }\n",
    "    vec3 q = p - (cohsm_cell_location(m, c) - m.center) * (1.0 / m.radius);\n",
    "    vec3 f = cohsm_face_coordinates(q, face);\n",
    "    return vec3(f.yz / f.x * middle + middle, f.x * (1.0 - 2.0 * bias / size) * (m.radius / m.depth_far) * 65533.0);\n",
    "}\n",
    "\n",
    "int cohsm_compared_depth(float depth)\n",
    "{\n",
    "    if (!(depth >= 0.0)) return -1;\n",
    "    return depth < 65535.0 ? int(depth) : 65535;\n",
    "}\n",
    "\n",
    "uint cohsm_pixel(cohsm_maps m, vec2 at)\n",
    "{\n",
    "    float top = float(m.map_size);\n",
    "    if (m.positional) {                                 // rounding may leave the face by a hair\n",
    "        at.x = at.x < 0.0 ? 0.0 : at.x >= top ? top - 0.5 : at.x;\n",
    "        at.y = at.y < 0.0 ? 0.0 : at.y >= top ? top - 0.5 : at.y;\n",
    "    }\n",
    "    if (!(at.x >= 0.0 && at.x < top && at.y >= 0.0 && at.y < top)) return COHSM_NO_PIXEL;\n",
    "    uint p = uint(at.y) * m.map_size + uint(at.x);\n",
    "    return p >= m.pixel_begin && p < m.pixel_end ? p - m.pixel_begin : COHSM_NO_PIXEL;\n",
    "}\n",
    "\n",
    "float cohsm_lit(cohsm_maps m, vec2 at, uint place, int depth)\n",
    "{\n",
    "    if (depth < 0) return 1.0;\n",
    "    uint pixel = cohsm_pixel(m, at);\n",
    "    if (pixel == COHSM_NO_PIXEL) return 1.0;\n",
    "    return depth > int(cohsm_stored_depth(m, pixel, place)) ? 0.0 : 1.0;\n",
    "}\n",
    "\n",
    "// ---- generalised PCF: what is dark, weighted ----\n",
    "\n",
    "float cohsm_pcf_map(cohsm_maps m, uvec3 c, vec3 p, float bias)\n",
    "{\n",
    "    uint face;\n",
    "    vec3 seen = cohsm_see(m, c, p, bias, face);\n",
    "    if (!(abs(seen.x) < 1e6 && abs(seen.y) < 1e6)) return 0.0;\n",
    "    uint place = cohsm_place(m, c) + face * m.map_count;\n",
    "    int depth = cohsm_compared_depth(seen.z);\n",
    "    vec2 low = floor(seen.xy - 0.5), f = seen.xy - 0.5 - low;\n",
    "    float dark = 0.0;\n",
    "    for (int i = 0; i < 4; i++) {\n",
    "        vec2 corner = vec2(float(i & 1), float(i >> 1));\n",
    "        float weight = (corner.x > 0.0 ? f.x : 1.0 - f.x) * (corner.y > 0.0 ? f.y : 1.0 - f.y);\n",
    "        if (weight > 0.0) dark += weight * (1.0 - cohsm_lit(m, low + corner + 0.5, place, depth));\n",
    "    }\n",
    "    return dark;\n",
    "}\n",
    "\n",
    "float cohsm_pcf(cohsm_maps m, vec3 at, vec3 p, float bias)\n",
    "{\n",
    "    int corners = 1 << int(m.dimensions);\n",
    "    vec3 low = floor(at), f = at - low;\n",
    "    float dark = 0.0;\n",
    "    for (int i = 0; i < corners; i++) {\n",
    "        ivec3 step = ivec3(i & 1, (i >> 1) & 1, i >> 2);\n",
    "        float weight = step.x != 0 ? f.x : 1.0 - f.x;\n",
    "        ivec3 c = ivec3(low) + step;\n",
    "        if (m.dimensions > 1u) weight *= step.y != 0 ? f.y : 1.0 - f.y;\n",
    "        else c.y = 0;\n",
    "        if (m.dimensions > 2u) weight *= step.z != 0 ? f.z : 1.0 - f.z;\n",
    "        else c.z = 0;\n",
    "        if (weight > 0.0) dark += weight * cohsm_pcf_map(m, cohsm_wrap(m, c), p, bias);\n",
    "    }\n",
    "    return dark;\n",
    "}\n",
    "\n",
    "// ---- semi-local light ----\n",
    "\n",
    "vec3 cohsm_dop_axis(int i)\n",
    "{\n",
    "    if (i < 3) return vec3(i == 0, i == 1, i == 2);\n",
    "    if (i < 9) {\n",
    "        float s = (i & 1) != 0 ? 1.0 : -1.0;\n",
    "        return i < 5 ? vec3(1.0, s, 0.0) : i < 7 ? vec3(1.0, 0.0, s) : vec3(0.0, 1.0, s);\n",
    "    }\n",
    "    return i == 9 ? vec3(1.0) : i == 10 ? vec3(1.0, 1.0, -1.0) : i == 11 ? vec3(1.0, -1.0, 1.0) : vec3(-1.0, 1.0, 1.0);\n",
    "}\n",
    "\n",
    "// Least and greatest extent of the object along the axis, in radii about the centre.\n",
    "vec2 cohsm_dop(cohsm_maps m, int i, vec3 axis)\n",
    "{\n",
    "    uint at = 45u + 2u * uint(i);\n",
    "    return (uintBitsToFloat(uvec2(cohsm_word(m, at), cohsm_word(m, at + 1u))) - dot(axis, m.center)) / m.radius;\n",
    "}\n",
    "\n",
    "// 0: the hull is not between point and light; 1: it may be; 2: the light lies inside. All in radii about the centre.\n",
    "int cohsm_hull(cohsm_maps m, vec3 p, vec3 light)\n",
    "{\n",
    "    float enter = 0.0, leave = 1.0;\n",
    "    bool inside = true, between = true;\n",
    "    for (int i = 0; i < 13; i++) {\n",
    "        vec3 a = cohsm_dop_axis(i);\n",
    "        vec2 extent = cohsm_dop(m, i, a);\n",
    "        float to = dot(a, light), from = dot(a, p), step = to - from;\n",
    "        inside = inside && to >= extent.x && to <= extent.y;\n",
    "        if (step == 0.0) {\n",
    "            between = between && from >= extent.x && from <= extent.y;\n",
    "            continue;\n",
    "        }\n",
    "        vec2 t = (extent - from) / step;\n",
    "        enter = max(enter, min(t.x, t.y));\n",
    "        leave = min(leave, max(t.x, t.y));\n",
    "    }\n",
    "    return inside ? 2 : between && enter <= leave ? 1 : 0;\n",
    "}\n",
    "\n",
    "// ---- one object ----\n",
    "\n",
    "bool cohsm_usable(vec3 light)\n",
    "{\n",
    "    float square = dot(light, light);\n",
    "    return square > 0.0 && square < COHSM_HUGE;\n",
    "}\n",
    "\n",
    "float cohsm_jitter(cohsm_query q, uint dimension)\n",
    "{\n",
    "    return q.filtering == COHSM_FILTER_ROULETTE ? cohsm_random(q.seed, q.id, dimension) : 0.5;\n",
    "}\n",
    "\n",
    "// p and, for COHSM_LIGHT_POSITION, light in radii about the sphere's centre.\n",
    "float cohsm_visible_unit(cohsm_maps m, cohsm_query q, vec3 p, vec3 light)\n",
    "{\n",
    "    bool by_index = q.light == COHSM_LIGHT_INDEX;\n",
    "    if (q.light == COHSM_LIGHT_PARAMETER)\n",
    "        light = vec3(light.x, m.dimensions > 1u ? light.y : 0.0, m.dimensions > 2u ? light.z : 0.0);\n",
    "    if (!by_index && !cohsm_finite3(light)) return 1.0;\n",
    "    if (q.light == COHSM_LIGHT_POSITION) {\n",
    "        int hull = cohsm_hull(m, p, light);\n",
    "        if (hull != 1) return hull == 2 ? COHSM_REFUSED : 1.0;\n",
    "        light -= p;\n",
    "    }\n",
    "    if (!cohsm_finite3(p)) return 1.0;\n",
    "    if (q.light < COHSM_LIGHT_PARAMETER && !cohsm_usable(light)) return 1.0;\n",
    "    vec3 at = by_index ? vec3(0.0) : cohsm_domain_position(m, light, q.light);\n",
    "    uvec3 c;\n",
    "    if (by_index) {\n",
    "        if (floatBitsToUint(light.x) >= m.map_count) return 1.0;\n",
    "        c = cohsm_cell_split(m, floatBitsToUint(light.x));\n",
    "    } else {\n",
    "        vec3 moved = at + vec3(m.dimensions > 0u ? cohsm_jitter(q, 0u) : 0.5,\n",
    "                               m.dimensions > 1u ? cohsm_jitter(q, 1u) : 0.5,\n",
    "                               m.dimensions > 2u ? cohsm_jitter(q, 2u) : 0.5);\n",
    "        c = cohsm_wrap(m, ivec3(floor(moved)));\n",
    "    }\n",
    "    if (q.filtering == COHSM_FILTER_PCF) {\n",
    "        float dark = by_index ? cohsm_pcf_map(m, c, p, q.bias) : cohsm_pcf(m, at, p, q.bias);\n",
    "        return dark >= 0.999999 ? 0.0 : 1.0 - dark;\n",
    "    }\n",
    "    uint face;\n",
    "    vec3 seen = cohsm_see(m, c, p, q.bias, face);\n",
    "    if (q.filtering == COHSM_FILTER_ROULETTE)\n",
    "        seen.xy += vec2(cohsm_jitter(q, 3u) - 0.5, cohsm_jitter(q, 4u) - 0.5);\n",
    "    int depth = cohsm_compared_depth(seen.z);\n",
    "    uint pixel = depth < 0 ? COHSM_NO_PIXEL : cohsm_pixel(m, seen.xy);\n",
    "    if (pixel == COHSM_NO_PIXEL) return 1.0;\n",
    "    return depth > int(cohsm_stored_depth(m, pixel, cohsm_place(m, c) + face * m.map_count)) ? 0.0 : 1.0;\n",
    "}\n",
    "\n",
    "// Point and light in the object's space: 1 lit, 0 dark, between with PCF, or COHSM_REFUSED.\n",
    "float cohsm_visible(cohsm_maps m, cohsm_query q, vec3 point, vec3 light)\n",
    "{\n",
    "    float scale = 1.0 / m.radius;\n",
    "    if (q.light == COHSM_LIGHT_POSITION) light = (light - m.center) * scale;\n",
    "    return cohsm_visible_unit(m, q, (point - m.center) * scale, light);\n",
    "}\n",
    "\n",
    "// ---- scenes ----\n",
    "\n",
    "// A table of instances is `count` records of 4 texels from texel `table` on: three rows of the matrix from world to\n",
    "// object as floats, then the block's first texel, a float of yours (cohsm_instance_note), 0, 0. If you keep records and\n",
    "// headers elsewhere: COHSM_INSTANCE(table, i, k), texel k of record i, and COHSM_HEADER(i, k), texel k of its block.\n",
    "#ifndef COHSM_INSTANCE\n",
    "#define COHSM_INSTANCE(table, i, k) COHSM_TEXEL((table) + 4u * (i) + (k))\n",
    "#endif\n",
    "\n",
    "cohsm_maps cohsm_instance_maps(uint table, uint i)\n",
    "{\n",
    "    uint base = COHSM_INSTANCE(table, i, 3u).x;\n",
    "#ifdef COHSM_HEADER\n",
    "    return cohsm_unpack(base, COHSM_HEADER(i, 1u), COHSM_HEADER(i, 2u), COHSM_HEADER(i, 3u), COHSM_HEADER(i, 4u),\n",
    "                        COHSM_HEADER(i, 5u), COHSM_HEADER(i, 6u), COHSM_HEADER(i, 7u));\n",
    "#else\n",
    "    return cohsm_open(base);\n",
    "#endif\n",
    "}\n",
    "\n",
    "float cohsm_visible_instance(uint table, uint i, cohsm_query q, vec3 point, vec3 light)\n",
    "{\n",
    "    vec4 x = uintBitsToFloat(COHSM_INSTANCE(table, i, 0u)), y = uintBitsToFloat(COHSM_INSTANCE(table, i, 1u));\n",
    "    vec4 z = uintBitsToFloat(COHSM_INSTANCE(table, i, 2u));\n",
    "    cohsm_maps m = cohsm_instance_maps(table, i);\n",
    "    q.seed += 0x9e3779b9u * i;          // roulette: each instance draws for itself\n",
    "    point = vec3(dot(x.xyz, point) + x.w, dot(y.xyz, point) + y.w, dot(z.xyz, point) + z.w);\n",
    "    if (q.light < COHSM_LIGHT_PARAMETER) {\n",
    "        light = vec3(dot(x.xyz, light), dot(y.xyz, light), dot(z.xyz, light));\n",
    "        if (q.light == COHSM_LIGHT_POSITION) light += vec3(x.w, y.w, z.w);\n",
    "    }\n",
    "    return cohsm_visible(m, q, point, light);\n",
    "}\n",
    "\n",
    "float cohsm_instance_note(uint table, uint i) { return uintBitsToFloat(COHSM_INSTANCE(table, i, 3u).y); }\n",
    "\n",
    "// The product over all instances, the one that the point lies on first (COHSM_NO_SELF: a receiver only).\n",
    "float cohsm_visible_scene(uint table, uint count, uint self, cohsm_query q, vec3 point, vec3 light)\n",
    "{\n",
    "    float visible = 1.0;\n",
    "    for (uint i = 0u; i < count && visible > 0.0; i++) {        // one call, which is inlined, and no turn for nothing\n",
    "        uint instance = self >= count || i > self ? i : i == 0u ? self : i - 1u;\n",
    "        float one = cohsm_visible_instance(table, instance, q, point, light);\n",
    "        visible = one < 0.0 ? COHSM_REFUSED : visible * one;\n",
    "    }\n",
    "    return visible;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_csm_access_glsl[] = {
    "// csm_access - what the files cohsm_* ask of a program, from the textures that glbk_csm_bind binds.\n",
    "// uses: table csm_bindings\n",
    "#define COHSM_TEXEL(i) texelFetch(glbk_csm_blocks, glbk_table_at(i), 0)\n",
    "#define COHSM_LIGHT_TEXEL(i) texelFetch(glbk_csm_lights, glbk_table_at(i), 0)\n",
    "#define COHSM_LOBE(i) COHSM_LIGHT_TEXEL(i)\n",
    "#ifndef COHSM_LOBES\n",
    "#define COHSM_LOBES 1\n",
    "#endif\n"
};

static const char *const glbk__glsl_lib_csm_bindings_glsl[] = {
    "// csm_bindings - from the lists GLBK_CSM_* of gl_backend.h.\n",
    "uniform usampler2DArray glbk_csm_blocks;\n",
    "uniform usampler2DArray glbk_csm_lights;\n",
    "uniform usampler2D glbk_csm_place;\n",
    "uniform usampler2D glbk_csm_normal;\n",
    "uniform usampler2D glbk_csm_color;\n",
    "uniform usampler2D glbk_csm_gloss;\n",
    "uniform glbk_color_sampler glbk_csm_sum;\n",
    "uniform sampler2D glbk_csm_color_map;\n",
    "uniform sampler2D glbk_csm_gloss_map;\n",
    "uniform sampler2D glbk_csm_normal_map;\n",
    "uniform usampler2DArray glbk_csm_questions;\n",
    "uniform usampler2DArray glbk_csm_instances;\n",
    "uniform usampler2D glbk_csm_layer0;\n",
    "uniform usampler2D glbk_csm_layer1;\n",
    "uniform usampler2D glbk_csm_layer2;\n",
    "uniform usampler2D glbk_csm_opened;\n",
    "#if __VERSION__ >= 430\n",
    "layout(std430, binding = 1) readonly buffer glbk_csm_asked_storage { uvec4 glbk_csm_asked[]; };\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(std430, binding = 2) writeonly buffer glbk_csm_answers_storage { float glbk_csm_answers[]; };\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(std430, binding = 3) restrict buffer glbk_csm_records_storage { uvec4 glbk_csm_records[]; };\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(rgba32f, binding = 0) restrict uniform image2D glbk_csm_total;\n",
    "#endif\n"
};

static const char *const glbk__glsl_lib_csm_compress_glsl[] = {
    "// csm_compress - layers of a batch of views to segments, for one pixel: equation (1), greedily, as csm.h does.\n",
    "// uses: csm_bindings\n",
    "\n",
    "// What goes on from batch to batch. lo, hi: the grid values that the open segment may have; fresh: it has no view yet.\n",
    "struct csm_open { uint lo, hi; bool fresh; uint next; };\n",
    "\n",
    "// At most 12 segments end in a run: each is lo, hi << 8 (exact: the depth), exact << 16, the view that it ends before\n",
    "// << 17.\n",
    "struct csm_ended { uint count; uvec4 records[3]; };\n",
    "\n",
    "void csm_end(inout csm_ended ended, uint record)\n",
    "{\n",
    "    uint i = ended.count & 3u;\n",
    "    uvec4 r = uvec4(i == 0u ? record : 0u, i == 1u ? record : 0u, i == 2u ? record : 0u, i == 3u ? record : 0u);\n",
    "    if (ended.count < 4u) ended.records[0] += r;\n",
    "    else if (ended.count < 8u) ended.records[1] += r;\n",
    "    else ended.records[2] += r;\n",
    "    ended.count++;\n",
    "}\n",
    "\n",
    "uint csm_depth16(uint bits)\n",
    "{\n",
    "    float z = uintBitsToFloat(bits);\n",
    "    return z <= 1.0 ? uint(clamp(z * 65533.0, 0.0, 65533.0)) : 65535u;\n",
    "}\n",
    "\n",
    "// The interval of depths that separate the layers at one texel of the tiles.\n",
    "uvec2 csm_interval(ivec2 at)\n",
    "{\n",
    "    uint z1 = csm_depth16(texelFetch(glbk_csm_layer0, at, 0).x), upper;\n",
    "    uvec4 how = glbk_csm_peel.how;              // grid's top; far; positional; self_only\n",
    "    if (z1 == 65535u) return uvec2(how.w != 0u ? 0u : 65535u, 65535u);\n",
    "    if (how.y != 0u) {\n",
    "        upper = csm_depth16(texelFetch(glbk_csm_layer2, at, 0).x);\n",
    "        if (upper == 65535u) return uvec2(z1, 65535u);\n",
    "    } else {\n",
    "        upper = csm_depth16(texelFetch(glbk_csm_layer1, at, 0).x);\n",
    "        float thickness = glbk_csm_peel.values.z;\n",
    "        if (upper == 65535u) upper = z1 + 1u + uint(how.z != 0u ? thickness * float(z1) : thickness);\n",
    "    }\n",
    "    return uvec2(z1, upper > z1 ? min(upper - 1u, 65534u) : z1);\n",
    "}\n",
    "\n",
    "csm_ended csm_compress(ivec2 pixel, inout csm_open o)\n",
    "{\n",
    "    uint size = glbk_csm_peel.tiles.x, across = glbk_csm_peel.tiles.y, views = glbk_csm_peel.tiles.z;\n",
    "    uint top = glbk_csm_peel.how.x;\n",
    "    csm_ended ended = csm_ended(0u, uvec4[3](uvec4(0u), uvec4(0u), uvec4(0u)));\n",
    "    for (; o.next < views && ended.count < 11u; o.next++) {\n",
    "        uvec2 z = csm_interval(pixel + ivec2(uvec2(o.next % across, o.next / across) * size));\n",
    "        uint lo = (z.x * top + 65534u) / 65535u, hi = ((z.y + 1u) * top - 1u) / 65535u;\n",
    "        uint both_lo = max(o.lo, lo), both_hi = min(o.hi, hi);\n",
    "        bool fresh = false;\n",
    "        if (both_lo > both_hi) {\n",
    "            if (!o.fresh) csm_end(ended, o.lo | (o.hi << 8) | (o.next << 17));\n",
    "            both_lo = lo;\n",
    "            both_hi = hi;\n",
    "            if (lo > hi) {                      // no value of the grid fits: exact, a segment of its own\n",
    "                csm_end(ended, ((z.x + z.y) / 2u) | (1u << 16) | ((o.next + 1u) << 17));\n",
    "                both_lo = 0u;\n",
    "                both_hi = top;\n",
    "                fresh = true;\n",
    "            }\n",
    "        }\n",
    "        o.lo = both_lo;\n",
    "        o.hi = both_hi;\n",
    "        o.fresh = fresh;\n",
    "    }\n",
    "    return ended;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_csm_frame_glsl[] = {
    "// glbk_csm_frame, uniform block\n",
    "layout(std140) uniform glbk_csm_frame_block {\n",
    "    uvec4 light;\n",
    "    uvec4 sampling;\n",
    "    uvec4 range;\n",
    "    uvec4 tables;\n",
    "    vec4 query;\n",
    "    vec4 eye;\n",
    "    vec4 planes[8];\n",
    "} glbk_csm_frame;\n"
};

static const char *const glbk__glsl_lib_csm_gbuffer_glsl[] = {
    "// csm_gbuffer - the G-buffer of glbk_csm: four RGBA32UI textures, floats as their bits (docs/gpu-layouts.md).\n",
    "// uses: csm_point\n",
    "uint csm_pack_unit(vec3 n)          // a unit vector in 32 bits, octahedral; zero: 0xffffffff\n",
    "{\n",
    "    float sum = abs(n.x) + abs(n.y) + abs(n.z);\n",
    "    if (!(sum > 0.0)) return 0xffffffffu;\n",
    "    n /= sum;\n",
    "    vec2 p = n.z >= 0.0 ? n.xy : (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);\n",
    "    uvec2 q = uvec2(floor(clamp(p * 0.5 + 0.5, 0.0, 1.0) * 65534.0 + 0.5));\n",
    "    return q.x | (q.y << 16);\n",
    "}\n",
    "\n",
    "vec3 csm_unpack_unit(uint bits)     // 0xffffffff: none, zero\n",
    "{\n",
    "    if (bits == 0xffffffffu) return vec3(0.0);\n",
    "    vec2 p = vec2(float(bits & 0xffffu), float(bits >> 16)) * (2.0 / 65534.0) - 1.0;\n",
    "    float z = 1.0 - abs(p.x) - abs(p.y), t = max(-z, 0.0);\n",
    "    return cohsm_normalize(vec3(p.x + (p.x >= 0.0 ? -t : t), p.y + (p.y >= 0.0 ? -t : t), z));\n",
    "}\n",
    "\n",
    "// false: nothing is seen there.\n",
    "bool csm_read_point(ivec2 at, out csm_point p)\n",
    "{\n",
    "    uvec4 place = texelFetch(glbk_csm_place, at, 0), normal = texelFetch(glbk_csm_normal, at, 0);\n",
    "    uvec4 color = texelFetch(glbk_csm_color, at, 0), gloss = texelFetch(glbk_csm_gloss, at, 0);\n",
    "    p.position = uintBitsToFloat(place.xyz);\n",
    "    p.self = place.w;\n",
    "    p.normal = uintBitsToFloat(normal.xyz);\n",
    "    p.plane = (normal.w >> 8) & 0xffu;\n",
    "    p.geometric = csm_unpack_unit(color.w);\n",
    "    p.tangent = vec3(0.0);\n",
    "    uint type = normal.w & 0xffu;\n",
    "    vec4 values = uintBitsToFloat(gloss);\n",
    "    p.material = cohsm_material(type, uintBitsToFloat(color.xyz), vec3(0.0), 0.0, 0.0, 0.0, 0u, 0u);\n",
    "    if (type == COHSM_BRDF_PHONG) {\n",
    "        p.material.specular = values.xyz;\n",
    "        p.material.exponent = values.w;\n",
    "    } else if (type == COHSM_BRDF_METAL_ROUGH) {\n",
    "        p.material.metallic = values.x;\n",
    "        p.material.roughness = values.y;\n",
    "    } else if (type == COHSM_BRDF_LAFORTUNE) {\n",
    "        p.material.lobe = gloss.x;\n",
    "        p.material.lobe_count = gloss.y;\n",
    "        p.tangent = csm_unpack_unit(gloss.z);\n",
    "    }\n",
    "    return type != 0u;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_csm_instances_glsl[] = {
    "// csm_instances - instances of a scene, from what glbk_csm_bind binds: up to 16 are in the block, more in a table.\n",
    "// uses: csm_access\n",
    "#ifdef CSM_INSTANCES                // 1 or 16: no more instances than that, in the uniform block with their headers\n",
    "#define COHSM_INSTANCE(table, i, k) glbk_csm_scene.instances[11u * min(i, uint(CSM_INSTANCES) - 1u) + k]\n",
    "#define COHSM_HEADER(i, k) COHSM_INSTANCE(0u, i, 3u + k)\n",
    "#else\n",
    "uvec4 csm_instance(uint i, uint k)\n",
    "{\n",
    "    if (glbk_csm_scene.table.z != 0u) return glbk_csm_scene.instances[11u * min(i, 15u) + k];\n",
    "    return texelFetch(glbk_csm_instances, glbk_table_at(4u * i + k), 0);\n",
    "}\n",
    "#define COHSM_INSTANCE(table, i, k) csm_instance(i, k)\n",
    "#endif\n"
};

static const char *const glbk__glsl_lib_csm_object_glsl[] = {
    "// glbk_csm_object, uniform block\n",
    "layout(std140) uniform glbk_csm_object_block {\n",
    "    mat4 world;\n",
    "    mat4 clip;\n",
    "    uvec4 kinds;\n",
    "    uvec4 lobes;\n",
    "    vec4 diffuse;\n",
    "    vec4 gloss;\n",
    "    vec4 eye;\n",
    "} glbk_csm_object;\n"
};

static const char *const glbk__glsl_lib_csm_pattern_glsl[] = {
    "// csm_pattern - patterns of samples for cohsm_estimate, from the tables of the frame; two points stand in each texel, S\n",
    "// points make a pattern.\n",
    "// uses: csm_access\n",
    "#ifdef CSM_PATTERNS\n",
    "vec2 csm_pattern(uint at)\n",
    "{\n",
    "    uvec4 t = COHSM_LIGHT_TEXEL(glbk_csm_frame.tables.x + (at >> 1));\n",
    "    return uintBitsToFloat((at & 1u) != 0u ? t.zw : t.xy);\n",
    "}\n",
    "#define COHSM_PATTERN(j, k) csm_pattern((j) * glbk_csm_frame.sampling.x + (k))\n",
    "#endif\n"
};

static const char *const glbk__glsl_lib_csm_peel_glsl[] = {
    "// glbk_csm_peel, uniform block\n",
    "layout(std140) uniform glbk_csm_peel_block {\n",
    "    mat4 view;\n",
    "    vec4 values;\n",
    "    uvec4 tiles;\n",
    "    uvec4 how;\n",
    "} glbk_csm_peel;\n"
};

static const char *const glbk__glsl_lib_csm_point_glsl[] = {
    "// csm_point - what is shaded: a point of a surface with its material.\n",
    "// uses: csm_access cohsm_brdf\n",
    "struct csm_point {\n",
    "    vec3 position, normal;      // world; the unit shading normal\n",
    "    vec3 geometric;             // unit; offsets go along it, and light from below it is cut\n",
    "    vec3 tangent;               // for anisotropic lobes; zero for any\n",
    "    cohsm_material material;\n",
    "    uint self;                  // instance that the point lies on, or COHSM_NO_SELF\n",
    "    uint plane;                 // 1 + the receiver plane that it lies on, or 0\n",
    "};\n"
};

static const char *const glbk__glsl_lib_csm_scene_glsl[] = {
    "// glbk_csm_scene, uniform block\n",
    "layout(std140) uniform glbk_csm_scene_block {\n",
    "    uvec4 table;\n",
    "    uvec4 instances[176];\n",
    "} glbk_csm_scene;\n"
};

static const char *const glbk__glsl_lib_csm_shade_glsl[] = {
    "// csm_shade - direct light at one point: samples of one light from one scene, with visibility. One pass adds samples\n",
    "// range.x .. range.y - 1 of one light; glbk_csm_render loops over lights and ranges.\n",
    "//\n",
    "// CSM_SHAPE, CSM_ASK, CSM_FILTER: the light's shape, what the maps are asked by, the filter, as constants: each program\n",
    "// holds the code for one combination, which is a fraction of all.\n",
    "// uses: csm_pattern csm_instances cohsm_visible cohsm_estimate csm_point\n",
    "#if !defined(CSM_SHAPE) || !defined(CSM_ASK) || !defined(CSM_FILTER)\n",
    "#error \"csm_shade.glsl needs CSM_SHAPE, CSM_ASK and CSM_FILTER\"\n",
    "#endif\n",
    "\n",
    "// Receivers without maps count as infinite planes: a sample on the other side is not lit.\n",
    "bool csm_behind(csm_point p, vec3 direction, float range)\n",
    "{\n",
    "    for (uint i = 0u; i < glbk_csm_frame.tables.y; i++) {\n",
    "        vec4 plane = glbk_csm_frame.planes[i];\n",
    "        float height = dot(plane.xyz, p.position) - plane.w, end = height + range * dot(plane.xyz, direction);\n",
    "        if (i + 1u != p.plane && (height > 0.0 ? end < 0.0 : end > 0.0)) return true;\n",
    "    }\n",
    "    return false;\n",
    "}\n",
    "\n",
    "// The sum of this pass: rgb, and in a the samples that were refused (their light lies inside a hull).\n",
    "vec4 csm_shade(csm_point p, uint pixel)\n",
    "{\n",
    "    uvec4 sampling = glbk_csm_frame.sampling, range = glbk_csm_frame.range;\n",
    "    const uint table = 0u;\n",
    "    uint count = glbk_csm_frame.light.z;\n",
    "    const int ask = CSM_ASK;\n",
    "    cohsm_light light = cohsm_light_open(glbk_csm_frame.light.x);\n",
    "    light.shape = uint(CSM_SHAPE);\n",
    "    vec3 view = cohsm_normalize(glbk_csm_frame.eye.xyz - p.position);\n",
    "    cohsm_surface surface = cohsm_surface_at(p.material, p.normal, p.tangent, view);\n",
    "    cohsm_estimator e = cohsm_estimator_at(surface, light, p.position, int(sampling.w), sampling.x, sampling.y,\n",
    "                                           sampling.z);\n",
    "    vec4 sum = vec4(0.0);\n",
    "    if (!e.reachable) return sum;\n",
    "\n",
    "    bool local = ask == COHSM_LIGHT_PARAMETER || (ask == COHSM_LIGHT_INDEX && light.shape > COHSM_SHAPE_SUN);\n",
    "    float moved = 0.0;          // how far the receiver moves off its surface\n",
    "    if (local && count > 0u)\n",
    "        moved = glbk_csm_frame.query.y * 2.0 / float(cohsm_instance_maps(table, 0u).map_size);\n",
    "    else if (p.self < count)\n",
    "        moved = cohsm_instance_note(table, p.self);\n",
    "    for (uint k = range.x; k < range.y; k++) {\n",
    "        cohsm_emission found;\n",
    "        vec3 weight = cohsm_estimate(e, cohsm_numbers(e, pixel, k), found);\n",
    "        if (!(weight.x > 0.0 || weight.y > 0.0 || weight.z > 0.0) || !(dot(found.direction, p.geometric) > 0.0) ||\n",
    "            csm_behind(p, found.direction, found.range))\n",
    "            continue;\n",
    "        vec3 from = p.position + p.geometric * (local ? moved * found.range : moved);\n",
    "        vec3 to = ask == COHSM_LIGHT_DIRECTION ? found.direction\n",
    "                : ask == COHSM_LIGHT_POSITION ? p.position + found.direction * found.range\n",
    "                : ask == COHSM_LIGHT_PARAMETER ? found.coords : vec3(0.0);\n",
    "        cohsm_query q = cohsm_query(ask, CSM_FILTER, glbk_csm_frame.query.x, range.w, pixel * sampling.x + k);\n",
    "        float visible = cohsm_visible_scene(table, count, p.self, q, from, to);\n",
    "        if (visible < 0.0) sum.a += 1.0;\n",
    "        else sum.rgb += weight * visible;\n",
    "    }\n",
    "    return vec4(sum.rgb * (1.0 / float(sampling.x)), sum.a);\n",
    "}\n"
};

static const char *const glbk__glsl_lib_csm_visible_glsl[] = {
    "// csm_visible - is a point lit in the scene that glbk_csm_bind bound: for your own shader.\n",
    "// uses: csm_instances cohsm_visible\n",
    "\n",
    "// self: the instance that the point lies on, or COHSM_NO_SELF. light: see cohsm_visible.glsl.\n",
    "float csm_visible(uint self, cohsm_query query, vec3 point, vec3 light)\n",
    "{\n",
    "    return cohsm_visible_scene(0u, glbk_csm_scene.table.y, self, query, point, light);\n",
    "}\n"
};

static const char *const glbk__glsl_lib_envsh_access_glsl[] = {
    "// envsh_access - what envsh_visible asks of a program, from what glbk_envsh_bind binds.\n",
    "// uses: table envsh_bindings\n",
    "#ifndef ENVSH_RGBA\n",
    "#error \"ENVSH_RGBA: 1 where four maps share a texel (glbk_envsh_maps_desc.rgba), else 0\"\n",
    "#endif\n",
    "#ifndef ENVSH_TEXEL\n",
    "#define ENVSH_TEXEL(i) texelFetch(glbk_envsh_views, glbk_table_at(i), 0)\n",
    "#endif\n",
    "#define ENVSH_STORED(view, at) envsh_stored(view.light, view.place, at)\n",
    "#define ENVSH_CELL(view, at, level) envsh_cell(view.light, view.place, at, level)\n",
    "\n",
    "ivec2 envsh_slot(uint place) { return ivec2(uvec2(place & 2047u, (place >> 11) & 2047u)); }\n",
    "\n",
    "float envsh_stored(uint light, uint place, ivec2 at)\n",
    "{\n",
    "    ivec3 texel = ivec3(envsh_slot(place) * int(glbk_envsh_scene.tiles.x) + at, int(place >> 22));\n",
    "#if ENVSH_RGBA\n",
    "    return uintBitsToFloat(texelFetch(glbk_envsh_depth4, texel, 0)[light & 3u]);\n",
    "#else\n",
    "    return texelFetch(glbk_envsh_depth, texel, 0).x;\n",
    "#endif\n",
    "}\n",
    "\n",
    "vec2 envsh_cell(uint light, uint place, ivec2 at, int level)\n",
    "{\n",
    "    uint channels = ENVSH_RGBA == 1 ? 4u : 1u;\n",
    "    int layer = int((place >> 22) * channels + (light & (channels - 1u)));\n",
    "    ivec2 corner = envsh_slot(place) * (int(glbk_envsh_scene.tiles.w) >> level);\n",
    "    return uintBitsToFloat(texelFetch(glbk_envsh_cells, ivec3(corner + at, layer), level).xy);\n",
    "}\n"
};

static const char *const glbk__glsl_lib_envsh_bindings_glsl[] = {
    "// envsh_bindings - from the lists GLBK_ENVSH_* of gl_backend.h.\n",
    "uniform sampler2DArray glbk_envsh_depth;\n",
    "uniform usampler2DArray glbk_envsh_depth4;\n",
    "uniform usampler2DArray glbk_envsh_cells;\n",
    "uniform usampler2DArray glbk_envsh_views;\n",
    "uniform usampler2D glbk_envsh_place;\n",
    "uniform usampler2D glbk_envsh_normal;\n",
    "uniform usampler2D glbk_envsh_flat;\n",
    "uniform usampler2D glbk_envsh_color;\n",
    "uniform glbk_color_sampler glbk_envsh_sum;\n",
    "uniform sampler2D glbk_envsh_color_map;\n",
    "#if __VERSION__ >= 430\n",
    "layout(rgba32f, binding = 0) restrict uniform image2D glbk_envsh_total;\n",
    "#endif\n"
};

static const char *const glbk__glsl_lib_envsh_cast_glsl[] = {
    "// envsh_cast - a caster's vertices and fragments in the tile of a light; gl_InstanceID says of which.\n",
    "// uses: table envsh_bindings\n",
    "// The vertex shader has \"out float envsh_depth;\" and ENVSH_CAST(world); the fragment shader \"in float envsh_depth;\"\n",
    "// and, behind what it discards, ENVSH_STORE(envsh_depth). With ENVSH_RGBA it has \"layout(location = 0) out uvec4\n",
    "// envsh_bits;\".\n",
    "#ifndef ENVSH_RGBA\n",
    "#error \"ENVSH_RGBA: 1 where four maps share a texel (glbk_envsh_maps_desc.rgba), else 0\"\n",
    "#endif\n",
    "\n",
    "struct envsh_vertex { vec4 position, inside; float depth; };\n",
    "\n",
    "// Triangles end at the tile's guard. OpenGL clips them by distances and clamps their depth. ES has neither: there the\n",
    "// viewport is a column of tiles and clips along x, the near and far planes stand in along y, and the depth is written.\n",
    "envsh_vertex envsh_cast(int instance, vec3 world)\n",
    "{\n",
    "    uint at = 8u * (glbk_envsh_object.lights.x + glbk_envsh_object.lights.y * uint(instance));\n",
    "    vec4 p = vec4(world, 1.0);\n",
    "    uvec4 tiles = glbk_envsh_scene.tiles;\n",
    "    vec2 texel = vec2(dot(uintBitsToFloat(texelFetch(glbk_envsh_views, glbk_table_at(at), 0)), p),\n",
    "                      dot(uintBitsToFloat(texelFetch(glbk_envsh_views, glbk_table_at(at + 1u), 0)), p));\n",
    "    uint place = texelFetch(glbk_envsh_views, glbk_table_at(at + 6u), 0).w;\n",
    "    vec2 corner = vec2(uvec2(place & 2047u, (place >> 11) & 2047u) * tiles.x);\n",
    "    envsh_vertex v;\n",
    "    v.depth = dot(uintBitsToFloat(texelFetch(glbk_envsh_views, glbk_table_at(at + 2u), 0)), p);\n",
    "    v.inside = vec4(texel - float(tiles.y), float(tiles.x - tiles.y) - texel);\n",
    "#ifdef GL_ES\n",
    "    vec2 inner = v.inside.xy * glbk_envsh_scene.page.z - 1.0;\n",
    "    v.position = vec4(inner.x, (corner.y + texel.y) * glbk_envsh_scene.page.y - 1.0, inner.y, 1.0);\n",
    "#else\n",
    "    v.position = vec4((corner + texel) * glbk_envsh_scene.page.xy - 1.0, 2.0 * v.depth - 1.0, 1.0);\n",
    "#endif\n",
    "    return v;\n",
    "}\n",
    "\n",
    "#ifdef GL_ES\n",
    "#define ENVSH_CLIP(d)\n",
    "#define ENVSH_WRITE_DEPTH(depth) gl_FragDepth = clamp(depth, 0.0, 1.0);\n",
    "#else\n",
    "#define ENVSH_CLIP_PART(i, d) gl_ClipDistance[i] = d;\n",
    "#define ENVSH_CLIP(d) ENVSH_CLIP_PART(0, d.x) ENVSH_CLIP_PART(1, d.y) ENVSH_CLIP_PART(2, d.z) ENVSH_CLIP_PART(3, d.w)\n",
    "#define ENVSH_WRITE_DEPTH(depth)\n",
    "#endif\n",
    "#define ENVSH_SET(v) gl_Position = v.position; envsh_depth = v.depth; ENVSH_CLIP(v.inside)\n",
    "#define ENVSH_CAST(world) { envsh_vertex envsh_v = envsh_cast(gl_InstanceID, world); ENVSH_SET(envsh_v) }\n",
    "\n",
    "#if ENVSH_RGBA\n",
    "#define ENVSH_STORE(depth) { envsh_bits = uvec4(floatBitsToUint(clamp(depth, 0.0, 1.0))); ENVSH_WRITE_DEPTH(depth) }\n",
    "#else\n",
    "#define ENVSH_STORE(depth) { ENVSH_WRITE_DEPTH(depth) }\n",
    "#endif\n"
};

static const char *const glbk__glsl_lib_envsh_chunk_glsl[] = {
    "// envsh_chunk - the lights' table through shared memory, 64 lights at a time, for groups of 64; before envsh_access.\n",
    "// uses: table envsh_bindings\n",
    "\n",
    "// A light's eight texels are turned by its number: neither one light for all threads nor one for each meet in a bank.\n",
    "#define ENVSH_TEXEL(i) envsh_chunk[((i) & 504u) | (((i) ^ ((i) >> 3)) & 7u)]\n",
    "shared uvec4 envsh_chunk[512];\n",
    "\n",
    "void envsh_load_chunk(uint from, uint to)\n",
    "{\n",
    "    for (uint i = 8u * from + gl_LocalInvocationIndex; i < 8u * min(from + 64u, to); i += 64u)\n",
    "        ENVSH_TEXEL(i) = texelFetch(glbk_envsh_views, glbk_table_at(i), 0);\n",
    "}\n"
};

static const char *const glbk__glsl_lib_envsh_disc_glsl[] = {
    "// envsh_disc - points of the filter's disc, from the query that glbk_envsh_bind binds.\n",
    "// uses: envsh_bindings\n",
    "#define ENVSH_DISC(i) (((i) & 1u) != 0u ? glbk_envsh_query.disc[(i) >> 1].zw : glbk_envsh_query.disc[(i) >> 1].xy)\n"
};

static const char *const glbk__glsl_lib_envsh_group_glsl[] = {
    "// envsh_group - what is known of a light for all points of a group at once, so that few lights are asked for by each.\n",
    "// uses: envsh_visible\n",
    "\n",
    "// Bounds of the points, their shading normals and the surface's own.\n",
    "struct envsh_group { vec3 low, high, n_low, n_high, flat_low, flat_high; };\n",
    "\n",
    "// Do all vectors within the bounds point away from d?\n",
    "bool envsh_all_under(vec3 low, vec3 high, vec3 d) { return dot(max(low * d, high * d), vec3(1.0)) < -1e-5; }\n",
    "\n",
    "// The greatest half width of the filter's kernel, texels, where no depth passes z.\n",
    "vec2 envsh_group_reach(envsh_query q, envsh_view v, float z)\n",
    "{\n",
    "#if ENVSH_FILTER == 0\n",
    "    return vec2(0.01);\n",
    "#elif ENVSH_FILTER == 1\n",
    "    return vec2(q.radius + 1.01);\n",
    "#elif ENVSH_FILTER == 2\n",
    "    return vec2(q.radius + 0.01);\n",
    "#else       // the half axes grow with the depth, but where one is lengthened to 0.7\n",
    "    vec2 a, b;\n",
    "    envsh_kernel(q, v, z, a, b);\n",
    "    return abs(a) + abs(b) + 0.71;\n",
    "#endif\n",
    "}\n",
    "\n",
    "// 1: every point that faces the light is lit; 0: no light reaches any; -1: each has to be asked for. What envsh_visible\n",
    "// answers for a point is never another; a hundredth of a texel and 1e-6 of the sums stand for rounding.\n",
    "int envsh_group_visible(envsh_query q, envsh_group g, uint light)\n",
    "{\n",
    "    vec3 d = envsh_direction(light), center = 0.5 * (g.low + g.high), extent = 0.5 * (g.high - g.low);\n",
    "    if (envsh_all_under(g.n_low, g.n_high, d) || envsh_all_under(g.flat_low, g.flat_high, d)) return 0;\n",
    "    envsh_view v = envsh_read_view(light);\n",
    "    extent += 1.01 * q.bias * max(v.texel.x, v.texel.y);\n",
    "    if (!all(lessThan(extent, vec3(1e15)))) return -1;\n",
    "    vec4 middle = vec4(center, 1.0), wide = vec4(extent, 0.0) + 1e-6 * vec4(abs(center) + extent, 1.0);\n",
    "    vec2 at = vec2(dot(v.row_x, middle), dot(v.row_y, middle));\n",
    "    vec2 across = vec2(dot(abs(v.row_x), wide), dot(abs(v.row_y), wide));\n",
    "    float z = dot(v.row_z, middle), deep = dot(abs(v.row_z), wide);\n",
    "    vec3 n = 0.5 * (g.flat_low + g.flat_high), n_extent = 0.5 * (g.flat_high - g.flat_low);\n",
    "    vec2 flat_n = abs(vec2(dot(n, v.right), dot(n, v.up)));\n",
    "    flat_n += vec2(dot(n_extent, abs(v.right)), dot(n_extent, abs(v.up)));\n",
    "    float cosine = max(dot(n, d) - dot(n_extent, abs(d)), 0.1);\n",
    "    vec2 reach = envsh_group_reach(q, v, z + deep);\n",
    "    float slope = 1.001 * dot(flat_n * v.texel, reach + 1.0) / (cosine * v.depth_range);\n",
    "    return envsh_decide_box(q, v, at, across + reach, z - deep - min(slope, 1.001 * envsh_plane_limit(q, v)),\n",
    "                            z + deep + slope);\n",
    "}\n"
};

static const char *const glbk__glsl_lib_envsh_light_glsl[] = {
    "// envsh_light - light of all directions with its shadows, for your own shader: what glbk_envsh_bind bound.\n",
    "// uses: envsh_access envsh_disc envsh_visible\n",
    "envsh_query envsh_bound_query()\n",
    "{\n",
    "    vec4 values = glbk_envsh_query.values;\n",
    "    return envsh_query(values.x, values.y, values.z, glbk_envsh_query.numbers.x, glbk_envsh_query.numbers.y,\n",
    "                       int(glbk_envsh_scene.tiles.x), int(glbk_envsh_scene.range.y));\n",
    "}\n",
    "\n",
    "// Irradiance, W/m^2: times albedo / pi it is the radiance of a diffuse surface. index: another for each pixel.\n",
    "vec3 envsh_light(vec3 p, vec3 n, vec3 flat_n, uint index)\n",
    "{\n",
    "    return envsh_irradiance(envsh_bound_query(), 0u, glbk_envsh_scene.range.x, p, n, flat_n, index);\n",
    "}\n"
};

static const char *const glbk__glsl_lib_envsh_object_glsl[] = {
    "// glbk_envsh_object, uniform block\n",
    "layout(std140) uniform glbk_envsh_object_block {\n",
    "    mat4 world;\n",
    "    mat4 clip;\n",
    "    vec4 color;\n",
    "    vec4 eye;\n",
    "    uvec4 lights;\n",
    "} glbk_envsh_object;\n"
};

static const char *const glbk__glsl_lib_envsh_query_glsl[] = {
    "// glbk_envsh_query, uniform block\n",
    "layout(std140) uniform glbk_envsh_query_block {\n",
    "    vec4 values;\n",
    "    uvec4 numbers;\n",
    "    uvec4 range;\n",
    "    vec4 disc[32];\n",
    "} glbk_envsh_query;\n"
};

static const char *const glbk__glsl_lib_envsh_scene_glsl[] = {
    "// glbk_envsh_scene, uniform block\n",
    "layout(std140) uniform glbk_envsh_scene_block {\n",
    "    uvec4 tiles;\n",
    "    uvec4 range;\n",
    "    vec4 page;\n",
    "} glbk_envsh_scene;\n"
};

static const char *const glbk__glsl_lib_envsh_visible_glsl[] = {
    "// envsh_visible - visibility of directional lights by their shadow maps: sections filter and shade of envshadow.h.\n",
    "// The program defines:\n",
    "//   ENVSH_FILTER             envsh_filter: 0 plain, 1 smoothing, 2 percentage closer, 3 penumbra\n",
    "//   ENVSH_TEXEL(i)           uvec4, texel i of the lights' table (docs/gpu-layouts.md)\n",
    "//   ENVSH_STORED(view, at)   float, the depth at texel `at` of the view's tile\n",
    "//   ENVSH_CELL(view, at, l)  vec2, least and greatest depth of a cell of 8 << l texels a side\n",
    "//   ENVSH_DISC(i)            vec2, tap i on the unit disc\n",
    "#if !(defined ENVSH_FILTER && defined ENVSH_TEXEL && defined ENVSH_STORED && defined ENVSH_CELL && defined ENVSH_DISC)\n",
    "#error \"envsh_visible: ENVSH_FILTER, ENVSH_TEXEL, ENVSH_STORED, ENVSH_CELL, ENVSH_DISC\"\n",
    "#endif\n",
    "\n",
    "struct envsh_query {\n",
    "    float radius, bias, extent_scale;\n",
    "    uint taps, seed;\n",
    "    int size, levels;               // texels a side of a tile; levels of cells\n",
    "};\n",
    "\n",
    "struct envsh_view {\n",
    "    vec4 row_x, row_y, row_z;       // world to texels of the tile and depth\n",
    "    vec3 right, up;\n",
    "    vec2 texel;                     // world size\n",
    "    float depth_range;\n",
    "    vec4 spread;\n",
    "    uint light, place;              // its number; column, row and page of its tile: 11, 11, 10 bits\n",
    "};\n",
    "\n",
    "struct envsh_receiver {\n",
    "    vec2 at, slope;                 // texels; of its plane's depth over texels\n",
    "    float z, limit;                 // depth; how far the slope may bring a tap towards the light\n",
    "};\n",
    "\n",
    "vec4 envsh_texel(uint light, uint i) { return uintBitsToFloat(ENVSH_TEXEL(8u * light + i)); }\n",
    "\n",
    "vec3 envsh_direction(uint light) { return envsh_texel(light, 5u).xyz; }\n",
    "vec3 envsh_power(uint light) { return envsh_texel(light, 6u).xyz; }     // irradiance on a plane that faces the light\n",
    "\n",
    "envsh_view envsh_read_view(uint light)\n",
    "{\n",
    "    envsh_view v;\n",
    "    vec4 right = envsh_texel(light, 3u), up = envsh_texel(light, 4u);\n",
    "    v.row_x = envsh_texel(light, 0u);\n",
    "    v.row_y = envsh_texel(light, 1u);\n",
    "    v.row_z = envsh_texel(light, 2u);\n",
    "    v.right = right.xyz;\n",
    "    v.up = up.xyz;\n",
    "    v.texel = vec2(right.w, up.w);\n",
    "    v.depth_range = envsh_texel(light, 5u).w;\n",
    "    v.place = ENVSH_TEXEL(8u * light + 6u).w;\n",
    "    v.spread = envsh_texel(light, 7u);\n",
    "    v.light = light;\n",
    "    return v;\n",
    "}\n",
    "\n",
    "uint envsh_hash32(uint x)\n",
    "{\n",
    "    uint state = x * 747796405u + 2891336453u;\n",
    "    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;\n",
    "    return (word >> 22) ^ word;\n",
    "}\n",
    "\n",
    "uint envsh_hash_combine(uint a, uint b) { return envsh_hash32(a + 0x9e3779b9u * envsh_hash32(b)); }\n",
    "\n",
    "// Cosine and sine of 0 .. 2 pi with envshadow.h's digits: those of drivers are off by enough to change a tap's texel.\n",
    "vec2 envsh_turn(float x)\n",
    "{\n",
    "    int k = int(x * 0.636619772 + 0.5);\n",
    "    float r = ((x - float(k) * 1.5703125) - float(k) * 4.837512969970703125e-4) - float(k) * 7.5497899548918822e-8;\n",
    "    float z = r * r, s = r + r * z * (-0.1666665494 + z * (0.008332178146 + z * -0.0001951729898));\n",
    "    float c = (1.0 - 0.5 * z) + z * z * (0.04166664687 + z * (-0.001388736752 + z * 2.443845159e-5));\n",
    "    vec2 cs = (k & 1) != 0 ? vec2(s, c) : vec2(c, s);\n",
    "    return vec2(((k + 1) & 2) != 0 ? -cs.x : cs.x, (k & 2) != 0 ? -cs.y : cs.y);\n",
    "}\n",
    "\n",
    "ivec2 envsh_place(vec2 at) { return ivec2(floor(clamp(at, vec2(-64.0), vec2(8192.0)))); }\n",
    "\n",
    "bool envsh_outside(envsh_query q, ivec2 at)\n",
    "{\n",
    "    return any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(q.size)));\n",
    "}\n",
    "\n",
    "// Is the texel's centre on the receiver's plane lit? Beyond the tile nothing is in the way. stored: what was found.\n",
    "bool envsh_lit(envsh_query q, envsh_view v, envsh_receiver r, ivec2 at, out float stored)\n",
    "{\n",
    "    stored = 1.0;\n",
    "    if (envsh_outside(q, at)) return true;\n",
    "    stored = ENVSH_STORED(v, at);\n",
    "    float z = r.z + max(dot(r.slope, vec2(at) + 0.5 - r.at), -r.limit);\n",
    "    return stored >= 1.0 || z <= stored;\n",
    "}\n",
    "\n",
    "// 1 lit, 0 dark at depths nearest .. farthest within reach of `at`, -1 not known: by four cells as large as that.\n",
    "int envsh_decide_box(envsh_query q, envsh_view v, vec2 at, vec2 reach, float nearest, float farthest)\n",
    "{\n",
    "    ivec2 low = envsh_place(at - reach), high = envsh_place(at + reach), last = ivec2(q.size - 1);\n",
    "    if (any(lessThan(high, ivec2(0))) || any(greaterThan(low, last))) return 1;\n",
    "    bool outside = envsh_outside(q, low) || envsh_outside(q, high);\n",
    "    low = max(low, ivec2(0));\n",
    "    high = min(high, last);\n",
    "    int wide = max(high.x - low.x, high.y - low.y), level = 0;\n",
    "    while (level + 1 < q.levels && (8 << level) < wide) level++;\n",
    "    low >>= 3 + level;\n",
    "    high >>= 3 + level;\n",
    "    vec2 a = ENVSH_CELL(v, low, level), b = ENVSH_CELL(v, ivec2(high.x, low.y), level);\n",
    "    vec2 c = ENVSH_CELL(v, ivec2(low.x, high.y), level), d = ENVSH_CELL(v, high, level);\n",
    "    float least = min(min(a.x, b.x), min(c.x, d.x)), most = max(max(a.y, b.y), max(c.y, d.y));\n",
    "    if (least >= 1.0 || farthest <= least) return 1;\n",
    "    return !outside && most < 1.0 && nearest > most ? 0 : -1;\n",
    "}\n",
    "\n",
    "// The same for a receiver's kernel of those half widths.\n",
    "int envsh_decide(envsh_query q, envsh_view v, envsh_receiver r, vec2 reach)\n",
    "{\n",
    "    float slope = dot(abs(r.slope), reach + 1.0);\n",
    "    return envsh_decide_box(q, v, r.at, reach, r.z - min(slope, r.limit), r.z + slope);\n",
    "}\n",
    "\n",
    "// All texels whose centres are within radius + 1/2 along both axes, weights falling to 0 at radius + 1.\n",
    "float envsh_smooth(envsh_query q, envsh_view v, envsh_receiver r)\n",
    "{\n",
    "    int reach = int(q.radius) + 1;\n",
    "    ivec2 center = envsh_place(r.at);\n",
    "    float sum = 0.0, weights = 0.0, stored;\n",
    "    for (int y = -reach; y <= reach; y++)\n",
    "        for (int x = -reach; x <= reach; x++) {\n",
    "            ivec2 at = center + ivec2(x, y);\n",
    "            vec2 w = q.radius + 1.0 - abs(vec2(at) + 0.5 - r.at);\n",
    "            if (!(w.x > 0.0) || !(w.y > 0.0)) continue;\n",
    "            weights += w.x * w.y;\n",
    "            if (envsh_lit(q, v, r, at, stored)) sum += w.x * w.y;\n",
    "        }\n",
    "    return weights > 0.0 ? sum / weights : 1.0;\n",
    "}\n",
    "\n",
    "// Tap i on the ellipse of half axes a and b, turned by the unit vector cs.\n",
    "ivec2 envsh_tap(envsh_receiver r, uint i, vec2 a, vec2 b, vec2 cs)\n",
    "{\n",
    "    vec2 d = ENVSH_DISC(i);\n",
    "    return envsh_place(r.at + (d.x * cs.x - d.y * cs.y) * a + (d.x * cs.y + d.y * cs.x) * b);\n",
    "}\n",
    "\n",
    "float envsh_taps(envsh_query q, envsh_view v, envsh_receiver r, vec2 a, vec2 b, vec2 cs)\n",
    "{\n",
    "    float lit = 0.0, stored;\n",
    "    for (uint i = 0u; i < q.taps; i++) lit += envsh_lit(q, v, r, envsh_tap(r, i, a, b, cs), stored) ? 1.0 : 0.0;\n",
    "    return lit / float(q.taps);\n",
    "}\n",
    "\n",
    "// Shortens both half axes so that neither reaches beyond `most` texels, and lengthens them to at least 0.7 of one.\n",
    "void envsh_limit(inout vec2 a, inout vec2 b, float most)\n",
    "{\n",
    "    float la = length(a), lb = length(b), least = min(0.7, most), f;\n",
    "    f = la > most ? most / la : 1.0;\n",
    "    a *= f;\n",
    "    la *= f;\n",
    "    f = lb > most ? most / lb : 1.0;\n",
    "    b *= f;\n",
    "    lb *= f;\n",
    "    if (la < least) {\n",
    "        a = vec2(least, 0.0);\n",
    "        b = vec2(0.0, least);\n",
    "    } else if (lb < least) {\n",
    "        b = vec2(-a.y, a.x) * (least / la);\n",
    "    }\n",
    "}\n",
    "\n",
    "// Half axes of the kernel, texels, where the stratum spreads over a distance in depth; held where squares are still\n",
    "// numbers.\n",
    "void envsh_kernel(envsh_query q, envsh_view v, float away, out vec2 a, out vec2 b)\n",
    "{\n",
    "    away = min(max(away, 0.0) * q.extent_scale, 1e9);\n",
    "    a = clamp(v.spread.xy * away, -1e15, 1e15);\n",
    "    b = clamp(v.spread.zw * away, -1e15, 1e15);\n",
    "    envsh_limit(a, b, q.radius);\n",
    "}\n",
    "\n",
    "// The mean depth of what is in the way, then a kernel as wide as the stratum spreads over that distance.\n",
    "float envsh_penumbra(envsh_query q, envsh_view v, envsh_receiver r, vec2 cs)\n",
    "{\n",
    "    float blockers = 0.0, found = 0.0, stored;\n",
    "    vec2 a, b;\n",
    "    envsh_kernel(q, v, r.z, a, b);\n",
    "    int known = envsh_decide(q, v, r, abs(a) + abs(b));\n",
    "    if (known >= 0) return float(known);\n",
    "    for (uint i = 0u; i < q.taps; i++)\n",
    "        if (!envsh_lit(q, v, r, envsh_tap(r, i, a, b, cs), stored)) {\n",
    "            blockers += stored;\n",
    "            found += 1.0;\n",
    "        }\n",
    "    if (found == 0.0) return 1.0;\n",
    "    envsh_kernel(q, v, r.z - blockers / found, a, b);\n",
    "    return envsh_taps(q, v, r, a, b, cs);\n",
    "}\n",
    "\n",
    "// How far a tap may follow the receiver's plane towards the light, in depth.\n",
    "float envsh_plane_limit(envsh_query q, envsh_view v)\n",
    "{\n",
    "    float texels = ENVSH_FILTER == 3 ? 4.0 : ENVSH_FILTER == 0 ? 3.0 : q.radius + (ENVSH_FILTER == 1 ? 4.0 : 3.0);\n",
    "    return texels * max(v.texel.x, v.texel.y) / v.depth_range;\n",
    "}\n",
    "\n",
    "// Moves the point along its normal and takes it into the tile. cosine: of normal and light, above 0.\n",
    "envsh_receiver envsh_receive(envsh_query q, envsh_view v, vec3 p, vec3 n, float cosine)\n",
    "{\n",
    "    envsh_receiver r;\n",
    "    vec2 flat_n = vec2(dot(n, v.right), dot(n, v.up));\n",
    "    float texel = max(v.texel.x, v.texel.y);\n",
    "    p += n * (q.bias * texel * (0.25 + 0.75 * length(flat_n)));\n",
    "    r.at = vec2(dot(v.row_x, vec4(p, 1.0)), dot(v.row_y, vec4(p, 1.0)));\n",
    "    r.z = dot(v.row_z, vec4(p, 1.0));\n",
    "    r.slope = flat_n * v.texel / (max(cosine, 0.1) * v.depth_range);\n",
    "    r.limit = envsh_plane_limit(q, v);\n",
    "    return r;\n",
    "}\n",
    "\n",
    "// Visibility of a light, 0..1. n: the surface's own unit normal, on the side seen. index: another for each pixel.\n",
    "float envsh_visible(envsh_query q, uint light, vec3 p, vec3 n, uint index)\n",
    "{\n",
    "    float cosine = dot(n, envsh_direction(light)), stored;\n",
    "    if (!(cosine > 0.0)) return 0.0;\n",
    "    envsh_view v = envsh_read_view(light);\n",
    "    envsh_receiver r = envsh_receive(q, v, p, n, cosine);\n",
    "#if ENVSH_FILTER == 0\n",
    "    return envsh_lit(q, v, r, envsh_place(r.at), stored) ? 1.0 : 0.0;\n",
    "#elif ENVSH_FILTER == 1\n",
    "    int known = envsh_decide(q, v, r, vec2(q.radius + 1.0));\n",
    "    return known >= 0 ? float(known) : envsh_smooth(q, v, r);\n",
    "#else\n",
    "    vec2 cs = envsh_turn(6.28318531 * (float(envsh_hash_combine(q.seed, index) >> 8) * (1.0 / 16777216.0)));\n",
    "#if ENVSH_FILTER == 2\n",
    "    int known = envsh_decide(q, v, r, vec2(q.radius));\n",
    "    return known >= 0 ? float(known) : envsh_taps(q, v, r, vec2(q.radius, 0.0), vec2(0.0, q.radius), cs);\n",
    "#else\n",
    "    return envsh_penumbra(q, v, r, cs);\n",
    "#endif\n",
    "#endif\n",
    "}\n",
    "\n",
    "// Sum of visibility x cosine x irradiance of lights from .. to - 1, W/m^2. n: shading normal; flat_n: the surface's.\n",
    "vec3 envsh_irradiance(envsh_query q, uint from, uint to, vec3 p, vec3 n, vec3 flat_n, uint index)\n",
    "{\n",
    "    vec3 sum = vec3(0.0);\n",
    "    for (uint light = from; light < to; light++) {\n",
    "        float cosine = dot(n, envsh_direction(light));\n",
    "        if (cosine > 0.0) sum += envsh_visible(q, light, p, flat_n, index) * cosine * envsh_power(light);\n",
    "    }\n",
    "    return sum;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_ism_access_glsl[] = {
    "// ism_access - VPLs and the texels of their tiles, from what glbk_ism_bind binds.\n",
    "// uses: table ism_map ism_bindings\n",
    "struct ism_grid {               // what the texels of a tile depend on\n",
    "    float exponent;             // the VPL's, or -1 of a sky\n",
    "    vec4  across, down;         // ism_axis\n",
    "};\n",
    "\n",
    "struct ism_vpl {\n",
    "    vec3  position, normal, flux, axis;\n",
    "    float exponent, side;       // of the lobe; of the square that it stands for\n",
    "    float reach;                // within which near points take its place; 0 where there are none\n",
    "    bool  sky;                  // position is the direction to it\n",
    "    uint  window;               // of its tile\n",
    "    ism_grid grid;\n",
    "    mat3  frame;                // of its map: columns x, y, z\n",
    "};\n",
    "\n",
    "ism_grid ism_grid_of(float exponent, uint window)\n",
    "{\n",
    "    ism_grid g;\n",
    "    g.exponent = exponent;\n",
    "    ism_axes(window, glbk_ism_frame.maps.y, uint(glbk_ism_frame.values.y), g.across, g.down);\n",
    "    return g;\n",
    "}\n",
    "\n",
    "ism_vpl ism_read_vpl(uint v)\n",
    "{\n",
    "    ism_vpl l;\n",
    "    vec4 a = texelFetch(glbk_ism_vpls, glbk_table_at(4u * v), 0);\n",
    "    vec4 b = texelFetch(glbk_ism_vpls, glbk_table_at(4u * v + 1u), 0);\n",
    "    vec4 c = texelFetch(glbk_ism_vpls, glbk_table_at(4u * v + 2u), 0);\n",
    "    vec4 d = texelFetch(glbk_ism_vpls, glbk_table_at(4u * v + 3u), 0);\n",
    "    l.position = a.xyz;\n",
    "    l.sky = a.w < 0.0;\n",
    "    l.exponent = l.sky ? 1.0 : a.w;\n",
    "    l.normal = b.xyz;\n",
    "    l.side = b.w;\n",
    "    l.flux = c.xyz;\n",
    "    l.reach = glbk_ism_frame.near_points.x > 0u ? c.w : 0.0;\n",
    "    l.axis = l.exponent != 1.0 ? d.xyz : l.normal;\n",
    "    l.window = uint(d.w);\n",
    "    l.grid = ism_grid_of(a.w, l.window);\n",
    "    l.frame = ism_frame_of(ism_projection_of(l.exponent) == ISM_PROJECTION_LOBE && !l.sky ? l.axis : l.normal);\n",
    "    return l;\n",
    "}\n",
    "\n",
    "// Where a tile begins in the atlas, and its number.\n",
    "ivec2 ism_tile_at(uint v)\n",
    "{\n",
    "    uint tiles = glbk_ism_frame.maps.z, row = uint((float(v) + 0.5) / float(tiles));    // divided as in ism_axis\n",
    "    return ivec2(v - row * tiles, row) * int(glbk_ism_frame.maps.y);\n",
    "}\n",
    "\n",
    "uint ism_tile_of(ivec2 at)\n",
    "{\n",
    "    ivec2 tile = at / int(glbk_ism_frame.maps.y);\n",
    "    return uint(tile.y) * glbk_ism_frame.maps.z + uint(tile.x);\n",
    "}\n",
    "\n",
    "// Places of the square in texels of a tile, and back.\n",
    "vec2 ism_to_tile(ism_grid g, vec2 uv)\n",
    "{\n",
    "    float size = float(glbk_ism_frame.maps.y), rim = glbk_ism_frame.values.y;\n",
    "    return vec2(ism_zoom_axis(g.across, size, rim, uv.x), ism_zoom_axis(g.down, size, rim, uv.y));\n",
    "}\n",
    "\n",
    "vec2 ism_from_tile(ism_grid g, vec2 at)\n",
    "{\n",
    "    float size = float(glbk_ism_frame.maps.y), rim = glbk_ism_frame.values.y;\n",
    "    return vec2(ism_unzoom_axis(g.across, size, rim, at.x), ism_unzoom_axis(g.down, size, rim, at.y));\n",
    "}\n",
    "\n",
    "ism_grid ism_read_grid(uint v)\n",
    "{\n",
    "    return ism_grid_of(texelFetch(glbk_ism_vpls, glbk_table_at(4u * v), 0).w,\n",
    "                       uint(texelFetch(glbk_ism_vpls, glbk_table_at(4u * v + 3u), 0).w));\n",
    "}\n",
    "\n",
    "// Direction of a texel's centre in the tile's frame, of a sky its place.\n",
    "vec3 ism_texel_direction(ism_grid g, ivec2 texel)\n",
    "{\n",
    "    vec2 uv = ism_from_tile(g, vec2(texel) + 0.5);\n",
    "    if (g.exponent < 0.0) return vec3(2.0 * uv - 1.0, 1.0);\n",
    "    return ism_map_direction(ism_projection_of(g.exponent), g.exponent, uv);\n",
    "}\n"
};

static const char *const glbk__glsl_lib_ism_bindings_glsl[] = {
    "// ism_bindings - from the lists GLBK_ISM_* of gl_backend.h.\n",
    "uniform sampler2DArray glbk_ism_vpls;\n",
    "uniform usampler2DArray glbk_ism_points;\n",
    "uniform usampler2DArray glbk_ism_triangles;\n",
    "uniform sampler2DArray glbk_ism_positions;\n",
    "uniform glbk_color_sampler glbk_ism_surfels;\n",
    "uniform usampler2D glbk_ism_below;\n",
    "uniform usampler2D glbk_ism_pull1;\n",
    "uniform usampler2D glbk_ism_pull2;\n",
    "uniform usampler2D glbk_ism_pull3;\n",
    "uniform usampler2D glbk_ism_atlas;\n",
    "uniform glbk_color_sampler glbk_ism_place;\n",
    "uniform glbk_color_sampler glbk_ism_normal;\n",
    "uniform glbk_color_sampler glbk_ism_geometric;\n",
    "uniform glbk_color_sampler glbk_ism_albedo;\n",
    "uniform glbk_color_sampler glbk_ism_light;\n",
    "#if __VERSION__ >= 430\n",
    "layout(rgba32f, binding = 0) writeonly uniform image2D glbk_ism_surfels_out;\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(r32ui, binding = 1) writeonly uniform uimage2D glbk_ism_atlas_out;\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(rgba32f, binding = 2) writeonly uniform image2D glbk_ism_light_out;\n",
    "#endif\n"
};

static const char *const glbk__glsl_lib_ism_blur_glsl[] = {
    "// ism_blur - the mean over a window that holds each class once, of neighbours on the same smooth surface; then the\n",
    "// albedo. The program has ism_neighbour: what lies at a pixel, and its light; false: nothing, or beyond the picture.\n",
    "// uses: ism_gbuffer\n",
    "bool ism_neighbour(ivec2 at, out ism_receiver r, out vec4 light);\n",
    "\n",
    "vec4 ism_smooth(ivec2 at, ism_receiver c)\n",
    "{\n",
    "    int r = int(glbk_ism_view.size.z) / 2;\n",
    "    vec4 sum = vec4(0.0);\n",
    "    float weights = 0.0;\n",
    "    for (int j = -r; j <= r; j++)\n",
    "        for (int i = -r; i <= r; i++) {\n",
    "            ism_receiver o;\n",
    "            vec4 light;\n",
    "            if (!ism_neighbour(at + ivec2(i, j), o, light)) continue;\n",
    "            vec3 d = o.p - c.p;\n",
    "            float facing = max(dot(c.n, o.n), 0.0), off = abs(dot(c.n, d)) + abs(dot(o.n, d));\n",
    "            float weight = (abs(i) == r ? 0.5 : 1.0) * (abs(j) == r ? 0.5 : 1.0) * facing * facing;\n",
    "            if (off > 0.0) weight *= max(1.0 - off / sqrt(dot(d, d)), 0.0);\n",
    "            sum += weight * light;\n",
    "            weights += weight;\n",
    "        }\n",
    "    return weights > 0.0 ? sum / weights : sum;\n",
    "}\n",
    "\n",
    "// What is asked for of a receiver.\n",
    "vec4 ism_finished(ivec2 at, ism_receiver c)\n",
    "{\n",
    "    vec4 light = glbk_ism_view.size.z > 1u ? ism_smooth(at, c) : glbk_unpack(texelFetch(glbk_ism_light, at, 0));\n",
    "    if ((glbk_ism_view.size.w & 2u) != 0u) {\n",
    "        vec3 albedo = glbk_unpack(texelFetch(glbk_ism_albedo, at, 0)).xyz;\n",
    "        bvec3 good = bvec3(cohsm_finite(albedo.x), cohsm_finite(albedo.y), cohsm_finite(albedo.z));\n",
    "        light.xyz *= vec3(good.x ? max(albedo.x, 0.0) : 0.0, good.y ? max(albedo.y, 0.0) : 0.0,\n",
    "                          good.z ? max(albedo.z, 0.0) : 0.0) * (1.0 / COHSM_PI);\n",
    "    }\n",
    "    return light;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_ism_disc_glsl[] = {
    "// ism_disc - points as discs in the tiles of their VPLs.\n",
    "// uses: ism_access\n",
    "#define ISM_DEEPEST 1.84467429e19      // below 2^64, which the depth buffer does not hold\n",
    "\n",
    "struct ism_surfel {\n",
    "    vec3  at, g;                // middle and plane, in the tile's frame\n",
    "    float radius2, depth;\n",
    "    vec2  uv;\n",
    "    vec4  cut1, cut2;           // barycentric coordinates grow so along the disc, and are so much at its middle\n",
    "    ivec4 box;                  // first and last texel, of the tile\n",
    "};                              // cut1.w < -1: not cut off at its triangle's edges\n",
    "\n",
    "// false: not seen from the VPL's front.\n",
    "bool ism_place_surfel(ism_vpl l, vec3 p, vec3 normal, float area, inout ism_surfel s)\n",
    "{\n",
    "    mat3 frame = l.frame;\n",
    "    vec3 n = normal * frame;\n",
    "    s.radius2 = area * (1.0 / COHSM_PI);\n",
    "    if (l.sky) {\n",
    "        vec3 o = (p - glbk_ism_frame.sphere.xyz) * frame;\n",
    "        float r = glbk_ism_frame.sphere.w, slope = abs(n.z) > 0.05 ? 1.0 / n.z : 0.0;\n",
    "        s.depth = o.z + r;\n",
    "        s.uv = 0.5 * o.xy / r + 0.5;\n",
    "        s.at = vec3(o.xy, s.depth);\n",
    "        s.g = vec3(-n.xy * slope * r, s.depth + dot(n.xy, o.xy) * slope);\n",
    "        return all(greaterThanEqual(s.uv, vec2(0.0))) && all(lessThan(s.uv, vec2(1.0)));\n",
    "    }\n",
    "    vec3 o = (p - l.position) * frame;\n",
    "    float d2 = dot(o, o), along = dot(n, o);\n",
    "    s.depth = sqrt(d2);\n",
    "    s.at = o;\n",
    "    s.g = o / d2;\n",
    "    if (!(d2 > 1e-30) || !(o.z > 1e-3 * s.depth)) return false;\n",
    "    // the surface that the VPL lies on is no occluder in a lobe's tilted map either\n",
    "    bool lobe = ism_projection_of(l.exponent) == ISM_PROJECTION_LOBE;\n",
    "    if (lobe && !(abs(dot(frame * o, l.normal)) > 1e-3 * s.depth)) return false;\n",
    "    s.radius2 = min(s.radius2, (along > 0.0 && s.cut1.w < -1.0 ? 0.04 : 1.0) * d2);\n",
    "    if (abs(along) > 1e-3 * s.depth) s.g = n / along;\n",
    "    if (!ism_map_coordinates(ism_projection_of(l.exponent), l.exponent, o / s.depth, s.uv)) return false;\n",
    "    // it stands for its neighbours too, off their surface by about its radius: so much farther away it hides none\n",
    "    if (s.cut1.w < -1.0) {\n",
    "        float away = 1.0 + sqrt(s.radius2) / s.depth;\n",
    "        s.at *= away;\n",
    "        s.g /= away;\n",
    "        s.radius2 *= away * away;\n",
    "        s.depth *= away;\n",
    "    }\n",
    "    return true;\n",
    "}\n",
    "\n",
    "// Texels a unit of angle, or of a sky's space, at most, without a window.\n",
    "float ism_texels_per_unit(ism_vpl l)\n",
    "{\n",
    "    float size = float(glbk_ism_frame.maps.y);\n",
    "    uint p = ism_projection_of(l.exponent);\n",
    "    if (l.sky) return 0.5 * size / glbk_ism_frame.sphere.w;\n",
    "    if (p == ISM_PROJECTION_PARABOLOID) return 0.5 * size;\n",
    "    return 0.9 * size * (p == ISM_PROJECTION_LOBE ? sqrt(0.5 * (l.exponent + 1.0)) : 1.0);\n",
    "}\n",
    "\n",
    "// 2 x 2 tiles show 4 levels of opacity (paper 6.4).\n",
    "bool ism_dither(uvec2 tile, float opacity)\n",
    "{\n",
    "    uint i = (tile.y & 1u) * 2u + (tile.x & 1u);\n",
    "    return opacity > (i == 0u ? 0.125 : i == 1u ? 0.625 : i == 2u ? 0.875 : 0.375);\n",
    "}\n",
    "\n",
    "vec3 ism_corner(uint vertex) { return texelFetch(glbk_ism_positions, glbk_table_at(vertex), 0).xyz; }\n",
    "\n",
    "// The texels that it may touch.\n",
    "bool ism_box_surfel(ism_vpl l, inout ism_surfel s)\n",
    "{\n",
    "    int size = int(glbk_ism_frame.maps.y);\n",
    "    float most = float(size), reach = sqrt(s.radius2) * ism_texels_per_unit(l) / (l.sky ? 1.0 : s.depth);\n",
    "    if (!(reach > 0.0)) return false;\n",
    "    reach = min(reach, most);\n",
    "    if (l.window == 0u) {\n",
    "        s.box = ivec4(max(s.uv * most - reach, 0.0), min(ivec2(s.uv * most + reach), size - 1));\n",
    "    } else {\n",
    "        vec2 first = ism_to_tile(l.grid, s.uv - reach / most), last = ism_to_tile(l.grid, s.uv + reach / most);\n",
    "        s.box = ivec4(max(first, 0.0), min(ivec2(last), size - 1));\n",
    "    }\n",
    "    return true;\n",
    "}\n",
    "\n",
    "// Point `index` of the table in the map of VPL v; false: not there.\n",
    "bool ism_surfel_of(uint index, uint v, ism_vpl l, out ism_surfel s)\n",
    "{\n",
    "    uvec4 point = texelFetch(glbk_ism_points, glbk_table_at(index), 0);\n",
    "    float share = uintBitsToFloat(point.w);\n",
    "    if (!(share > 0.0) || point.x >= glbk_ism_frame.points.w) return false;\n",
    "    uvec4 t = texelFetch(glbk_ism_triangles, glbk_table_at(point.x), 0);\n",
    "    if (!ism_dither(uvec2(v % glbk_ism_frame.maps.z, v / glbk_ism_frame.maps.z), uintBitsToFloat(t.w))) return false;\n",
    "    vec3 p = ism_corner(t.x), e1 = ism_corner(t.y) - p, e2 = ism_corner(t.z) - p, n = cross(e1, e2);\n",
    "    float length2 = dot(n, n), size = sqrt(length2);\n",
    "    if (!(length2 > 0.0) || !cohsm_finite(length2)) return false;\n",
    "    vec2 b = uintBitsToFloat(point.yz);\n",
    "    float area = glbk_ism_frame.values.x * share * 0.5 * size;\n",
    "    p += e1 * b.x + e2 * b.y;\n",
    "    s.cut1 = s.cut2 = vec4(-2.0);\n",
    "    if (share < 1.0) {\n",
    "        s.cut1 = vec4((cross(e2, n) / length2) * l.frame, b.x);\n",
    "        s.cut2 = vec4((cross(n, e1) / length2) * l.frame, b.y);\n",
    "        area *= 6.0;\n",
    "    }\n",
    "    return ism_place_surfel(l, p, n / size, area, s) && ism_box_surfel(l, s);\n",
    "}\n",
    "\n",
    "// Where the ray through a texel of the tile, in direction w, meets the disc, or ISM_FAR where it does not, or beyond\n",
    "// the limit. No disc is widened to a whole texel.\n",
    "float ism_meet(bool sky, ism_surfel s, vec3 w, float limit)\n",
    "{\n",
    "    float t = ism_plane_depth(sky, s.g, w);\n",
    "    if (!(t > 0.0 && t <= min(limit, ISM_DEEPEST))) return ISM_FAR;\n",
    "    vec3 d = (sky ? vec3(w.xy * glbk_ism_frame.sphere.w, t) : w * t) - s.at;\n",
    "    if (!(dot(d, d) <= s.radius2)) return ISM_FAR;\n",
    "    vec2 b = vec2(s.cut1.w + dot(d, s.cut1.xyz), s.cut2.w + dot(d, s.cut2.xyz));\n",
    "    return s.cut1.w > -1.0 && !(min(b.x, b.y) >= -1e-4 && b.x + b.y <= 1.0001) ? ISM_FAR : t;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_ism_fill_glsl[] = {
    "// ism_fill - what the passes of pull and push share.\n",
    "// uses: ism_access\n",
    "#define ISM_HOLE 2\n",
    "#define ISM_LEVELS 3\n",
    "\n",
    "vec4 ism_surfel_at(ivec2 at) { return glbk_unpack(texelFetch(glbk_ism_surfels, at, 0)); }\n",
    "\n",
    "// Which of the four quadrants about a texel something lies in; each owns one half axis.\n",
    "uint ism_quadrant(ivec2 d)\n",
    "{\n",
    "    return d.x > 0 && d.y >= 0 ? 1u : d.x <= 0 && d.y > 0 ? 2u : d.x < 0 ? 4u : 8u;\n",
    "}\n",
    "\n",
    "// Which of eight sectors about a texel, of 45 degrees each about the axes and diagonals.\n",
    "uint ism_sector(ivec2 d)\n",
    "{\n",
    "    ivec2 a = abs(d);\n",
    "    if (12 * a.y < 5 * a.x) return d.x > 0 ? 1u : 16u;                      // tan 22.5 = 5 / 12\n",
    "    if (12 * a.x < 5 * a.y) return d.y > 0 ? 4u : 64u;\n",
    "    return d.x > 0 ? (d.y > 0 ? 2u : 128u) : d.y > 0 ? 8u : 32u;\n",
    "}\n",
    "\n",
    "uint ism_turn(uint sectors, int by) { return (sectors << by | sectors >> (8 - by)) & 255u; }\n",
    "\n",
    "// Is a texel with something in these sectors about it surrounded? All that lies on one side of a line touches five of\n",
    "// them at most. Those beyond the tile's border count where the border has something on both sides of the texel: in the\n",
    "// sector along it or, of what is close, the next one.\n",
    "bool ism_surrounded(uint found, uint close, uint beyond)\n",
    "{\n",
    "    uint along = (ism_turn(beyond, 1) | ism_turn(beyond, 7)) & ~beyond;\n",
    "    if (((found | ism_turn(close, 1) | ism_turn(close, 7)) & along) == along) found |= beyond;\n",
    "    uint open = ~found & 255u;\n",
    "    return (open & ism_turn(open, 1) & ism_turn(open, 2)) == 0u;\n",
    "}\n",
    "\n",
    "// Of a cell of 2^level texels a side, by its place in the tile, and 1 + the indices of one texel of each of its four\n",
    "// parts (0: none): the nearest to its middle. A part of level 1 is a texel, and not 0 where it keeps its surfel.\n",
    "uint ism_pull(int level, ivec2 cell, uvec4 parts)\n",
    "{\n",
    "    int size = int(glbk_ism_frame.maps.y), least = 0x7fffffff;\n",
    "    ivec2 middle = (2 * cell + 1) << level;\n",
    "    uint result = 0u;\n",
    "    for (int k = 0; k < 4; k++) {\n",
    "        ivec2 texel = 2 * cell + ivec2(k & 1, k >> 1);\n",
    "        int at = int(parts[k]);\n",
    "        if (at == 0) continue;\n",
    "        if (level == 1) at = texel.y * size + texel.x + 1;\n",
    "        ivec2 d = 2 * ivec2((at - 1) % size, (at - 1) / size) + 1 - middle;\n",
    "        if (d.x * d.x + d.y * d.y < least) {\n",
    "            least = d.x * d.x + d.y * d.y;\n",
    "            result = uint(at);\n",
    "        }\n",
    "    }\n",
    "    return result;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_ism_frame_glsl[] = {
    "// glbk_ism_frame, uniform block\n",
    "layout(std140) uniform glbk_ism_frame_block {\n",
    "    uvec4 maps;\n",
    "    uvec4 points;\n",
    "    vec4 sphere;\n",
    "    vec4 values;\n",
    "    uvec4 near_points;\n",
    "} glbk_ism_frame;\n"
};

static const char *const glbk__glsl_lib_ism_gbuffer_glsl[] = {
    "// ism_gbuffer - what is shaded: four textures of positions, shading normals, face normals and albedos.\n",
    "// uses: cohsm_math ism_bindings\n",
    "struct ism_receiver { vec3 p, n, ng; };\n",
    "\n",
    "// false: background, whose normal is not near unit length.\n",
    "bool ism_read_receiver(ivec2 at, out ism_receiver r)\n",
    "{\n",
    "    r.p = glbk_unpack(texelFetch(glbk_ism_place, at, 0)).xyz;\n",
    "    r.n = glbk_unpack(texelFetch(glbk_ism_normal, at, 0)).xyz;\n",
    "    r.ng = glbk_unpack(texelFetch(glbk_ism_geometric, at, 0)).xyz;\n",
    "    if (!cohsm_finite3(r.ng)) r.ng = r.n;\n",
    "    float n2 = dot(r.n, r.n);\n",
    "    return cohsm_finite3(r.p) && cohsm_finite3(r.n) && n2 > 0.25 && n2 < 4.0;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_ism_holes_glsl[] = {
    "// ism_holes - texels whose surfels others pass before. The program has ism_depth: a surfel's depth.\n",
    "// uses: ism_fill\n",
    "float ism_depth(ivec2 at);\n",
    "\n",
    "// Surfels in all four quadrants about it pass before it. at: in the atlas, where it has depth c.\n",
    "bool ism_hole(ism_grid grid, ivec2 at, float c)\n",
    "{\n",
    "    int size = int(glbk_ism_frame.maps.y);\n",
    "    ivec2 local = at & (size - 1);\n",
    "    vec3 w = ism_texel_direction(grid, local);\n",
    "    uint found = 0u;\n",
    "    for (int dy = -ISM_HOLE; dy <= ISM_HOLE; dy++)\n",
    "        for (int dx = -ISM_HOLE; dx <= ISM_HOLE; dx++) {\n",
    "            ivec2 d = ivec2(dx, dy), there = local + d;\n",
    "            if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, ivec2(size)))) {\n",
    "                found |= ism_quadrant(d);\n",
    "                continue;\n",
    "            }\n",
    "            float depth = ism_depth(at + d);\n",
    "            if (!(depth < 0.9 * c)) continue;\n",
    "            float t = ism_plane_depth(grid.exponent < 0.0, ism_surfel_at(at + d).xyz, w);\n",
    "            if (t > 0.5 * depth && t < 0.95 * c) found |= ism_quadrant(d);\n",
    "        }\n",
    "    return found == 15u;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_ism_light_glsl[] = {
    "// ism_light - light of VPLs, by the maps of glbk_ism_draw. For your own shader: glbk_ism_bind, then\n",
    "//\n",
    "//     vec4 e = ism_light(position, normal, geometric, 0u, 1u);     // irradiance, W/m^2; lost by the rule near by\n",
    "//\n",
    "// Defines: ISM_NEAR=1 patch, 2 sphere, 3 clamp, 4 clamp to the mean, 5 none, 6 gather; ISM_PROJECTION, the maps'\n",
    "// desc.projection.\n",
    "// uses: ism_access\n",
    "#ifndef ISM_NEAR\n",
    "#define ISM_NEAR 6\n",
    "#endif\n",
    "#define ISM_GRAZING 1e-4     // cosine, by the receiver's plane, below which a VPL counts as behind it: rounding\n",
    "\n",
    "float ism_luminance(vec3 f) { return (f.x + f.y + f.z) * (1.0 / 3.0); }\n",
    "\n",
    "// 1 lit, 0 not: compares depths on the receiver's tangent plane, at the centre of the texel.\n",
    "float ism_visible(uint v, ism_vpl l, vec3 p, vec3 ng, float bias)\n",
    "{\n",
    "    mat3 frame = l.frame;\n",
    "    int size = int(glbk_ism_frame.maps.y);\n",
    "    ivec2 tile = ism_tile_at(v), texel;\n",
    "    vec3 n = ng * frame;\n",
    "    if (l.sky) {\n",
    "        vec3 o = (p - glbk_ism_frame.sphere.xyz) * frame;\n",
    "        float r = glbk_ism_frame.sphere.w, depth = o.z + r;\n",
    "        vec2 uv = 0.5 * o.xy / r + 0.5;\n",
    "        if (!(n.z < -ISM_GRAZING)) return 0.0;\n",
    "        if (any(lessThan(uv, vec2(0.0))) || any(greaterThanEqual(uv, vec2(1.0)))) return 1.0;\n",
    "        texel = min(ivec2(ism_to_tile(l.grid, uv)), size - 1);\n",
    "        vec2 d = (2.0 * ism_from_tile(l.grid, vec2(texel) + 0.5) - 1.0) * r - o.xy;\n",
    "        if (abs(n.z) > 0.1) depth -= dot(n.xy, d) / n.z;\n",
    "        return depth - bias * r <= uintBitsToFloat(texelFetch(glbk_ism_atlas, tile + texel, 0).x) ? 1.0 : 0.0;\n",
    "    }\n",
    "    vec3 o = (p - l.position) * frame;\n",
    "    float d = sqrt(dot(o, o));\n",
    "    vec2 uv;\n",
    "    if (!(o.z > 0.0) || !(d > 0.0)) return 1.0;\n",
    "    if (!(dot(n, o) < -ISM_GRAZING * d)) return 0.0;\n",
    "    if (!ism_map_coordinates(ism_projection_of(l.exponent), l.exponent, o / d, uv)) return 1.0;\n",
    "    texel = min(ivec2(ism_to_tile(l.grid, uv)), size - 1);\n",
    "    float t = uintBitsToFloat(texelFetch(glbk_ism_atlas, tile + texel, 0).x);\n",
    "    if (d * (1.0 - bias) <= t && t >= 2.0 * d) return 1.0;\n",
    "    float along = dot(n, ism_texel_direction(l.grid, texel));\n",
    "    along = along != 0.0 ? dot(n, o) / along : d;\n",
    "    if (along > 0.5 * d && along < 2.0 * d) d = along;\n",
    "    return d * (1.0 - bias) <= t ? 1.0 : 0.0;\n",
    "}\n",
    "\n",
    "// An edge's share of Lambert's sum: angle(a, b) n . (b x a) / |b x a|.\n",
    "float ism_edge(vec3 n, vec3 a, vec3 b)\n",
    "{\n",
    "    vec3 c = cross(b, a);\n",
    "    float size = sqrt(dot(c, c));\n",
    "    return size > 0.0 ? cohsm_atan2(size, dot(a, b)) * (dot(n, c) / size) : 0.0;\n",
    "}\n",
    "\n",
    "// Form factor of the square d +- x +- y, clipped at the horizon of n; share: of its area that is left. Convex, so the\n",
    "// horizon cuts it once at most: where it leaves and where it comes back are joined.\n",
    "float ism_form_factor(vec3 n, vec3 d, vec3 x, vec3 y, out float share)\n",
    "{\n",
    "    vec3 leave = d, come = d, area = vec3(0.0);\n",
    "    float sum = 0.0;\n",
    "    bool cut = false;\n",
    "    for (int i = 0; i < 4; i++) {\n",
    "        vec3 a = d + (i == 0 || i == 3 ? -x : x) + (i < 2 ? -y : y);\n",
    "        vec3 b = d + (i < 2 ? x : -x) + (i == 0 || i == 3 ? -y : y);\n",
    "        float ha = dot(n, a), hb = dot(n, b);\n",
    "        if (!(ha > 0.0) && !(hb > 0.0)) continue;\n",
    "        if ((ha > 0.0) != (hb > 0.0)) {\n",
    "            vec3 at = a + (b - a) * (ha / (ha - hb));\n",
    "            cut = true;\n",
    "            if (ha > 0.0) b = leave = at;\n",
    "            else a = come = at;\n",
    "        }\n",
    "        sum += ism_edge(n, a, b);\n",
    "        area += cross(a - d, b - d);\n",
    "    }\n",
    "    if (cut) {\n",
    "        sum += ism_edge(n, leave, come);\n",
    "        area += cross(leave - d, come - d);\n",
    "    }\n",
    "    share = sqrt(dot(area, area)) / (8.0 * sqrt(dot(x, x) * dot(y, y)));\n",
    "    return sum * 0.159154943;\n",
    "}\n",
    "\n",
    "// To receivers that face the square no brighter than the point: the backs of bent sheets do. square: without that.\n",
    "float ism_patch_kernel(mat3 frame, float side, vec3 d, vec3 n, float point, out float square)\n",
    "{\n",
    "    float share, form = ism_form_factor(n, d, frame[0] * (0.5 * side), frame[1] * (0.5 * side), share);\n",
    "    float facing = -2.0 * dot(n, frame[2]);\n",
    "    square = form = form > 0.0 && share > 0.0 ? form * COHSM_PI / (side * side * share) : 0.0;\n",
    "    if (!(facing > 0.0) || !(form > point)) return form;\n",
    "    return form + min(facing, 1.0) * (point - form);\n",
    "}\n",
    "\n",
    "float ism_sphere_kernel(vec3 d, vec3 normal, vec3 n, float side)\n",
    "{\n",
    "    float r2 = side * side * (1.0 / COHSM_PI), d2 = dot(d, d), sum = 0.0;\n",
    "    float least = d2 > r2 ? sqrt(1.0 - r2 / d2) : -1.0;\n",
    "    mat3 frame = ism_frame_of(cohsm_normalize(d));\n",
    "    for (int k = 0; k < 16; k++) {\n",
    "        float cosine = 1.0 - (1.0 - least) * (float(k) + 0.5) * (1.0 / 16.0), sine = sqrt(1.0 - cosine * cosine);\n",
    "        vec2 sc = cohsm_sincos(2.39996323 * float(k));\n",
    "        vec3 w = frame * vec3(sine * sc.y, sine * sc.x, cosine);\n",
    "        float a = dot(n, w), b = -dot(normal, w);\n",
    "        if (a > 0.0 && b > 0.0) sum += a * b;\n",
    "    }\n",
    "    return sum * (1.0 / 16.0) * 2.0 * (1.0 - least) / r2;\n",
    "}\n",
    "\n",
    "// How far near points stand for what is at this distance: fully within 0.7 reach, not at all beyond it.\n",
    "float ism_nearness(float d2, float reach)\n",
    "{\n",
    "    float r2 = reach * reach, h = 2.0 * (r2 - d2);\n",
    "    return !(h > 0.0) ? 0.0 : h < r2 ? h / r2 : 1.0;\n",
    "}\n",
    "\n",
    "// cos cos / d^2 (cosine alone of a sky) with the lobe and the rule near by; plain without what that takes off.\n",
    "float ism_kernel(ism_vpl l, vec3 p, vec3 n, float most, out float plain)\n",
    "{\n",
    "    if (l.sky) return plain = max(dot(l.position, n) * COHSM_PI, 0.0);\n",
    "    vec3 d = l.position - p;\n",
    "    float d2 = dot(d, d), a = dot(n, d), b = -dot(l.normal, d), area = l.side * l.side;\n",
    "    plain = a > 0.0 && b > 0.0 ? a * b / (d2 * d2 + 1e-37) : 0.0;\n",
    "    if (l.exponent != 1.0) {\n",
    "        float c = -dot(l.axis, d) / sqrt(d2);\n",
    "        plain = c > 0.0 && a > 0.0 ? 0.5 * (l.exponent + 1.0) * cohsm_pow(c, l.exponent) * a / (sqrt(d2) * d2) : 0.0;\n",
    "        area = 0.0;\n",
    "    }\n",
    "    if (!(plain > 0.0)) return 0.0;\n",
    "#if ISM_NEAR == 1\n",
    "    if (!(area > 0.0 && d2 < 9.0 * area)) return plain;\n",
    "    float point = plain;\n",
    "    return ism_patch_kernel(l.frame, l.side, d, n, point, plain);\n",
    "#elif ISM_NEAR == 6\n",
    "    float share = 1.0 - ism_nearness(d2, l.reach), k = plain, point = plain;\n",
    "    if (!(share > 0.0)) return plain = 0.0;\n",
    "    if (area > 0.0 && d2 < 9.0 * area) k = ism_patch_kernel(l.frame, l.side, d, n, point, plain);\n",
    "    plain *= share;\n",
    "    return k * share;\n",
    "#elif ISM_NEAR == 2\n",
    "    return area > 0.0 && d2 < 16.0 * area ? ism_sphere_kernel(d, l.normal, n, l.side) : plain;\n",
    "#elif ISM_NEAR == 3\n",
    "    return min(plain, most);\n",
    "#else\n",
    "    return plain;\n",
    "#endif\n",
    "}\n",
    "\n",
    "// What VPL v adds to sum: irradiance times pi, and in w what the rule near by took off. most: of one VPL, clamped.\n",
    "void ism_add(inout vec4 sum, uint v, ism_vpl l, vec3 p, vec3 n, vec3 ng, float most)\n",
    "{\n",
    "    float plain, k = ism_kernel(l, p, n, most, plain), power = ism_luminance(l.flux);\n",
    "#if ISM_NEAR == 4\n",
    "    if (k * power > most) k = most / power;\n",
    "#endif\n",
    "    if (!(k > 0.0)) return;\n",
    "    if ((glbk_ism_view.size.w & 1u) == 0u) k *= ism_visible(v, l, p, ng, glbk_ism_view.values.x);\n",
    "    sum.xyz += k * l.flux;\n",
    "    if (k > 0.0) sum.w += max(plain - k, 0.0) * power;\n",
    "}\n",
    "\n",
    "// What it gives without a map, for the mean that ISM_NEAR 4 clamps to.\n",
    "float ism_unshadowed(ism_vpl l, vec3 p, vec3 n)\n",
    "{\n",
    "    float plain;\n",
    "    return ism_kernel(l, p, n, 0.0, plain) * ism_luminance(l.flux);\n",
    "}\n",
    "\n",
    "// VPLs first, first + pattern, ...: how many there are, and a sum over them times as many as there are such classes:\n",
    "// the mean over all classes is then the sum of all VPLs, however few there are.\n",
    "uint ism_used(uint first, uint pattern)\n",
    "{\n",
    "    uint count = glbk_ism_frame.maps.x;\n",
    "    return first < count ? (count - first - 1u) / pattern + 1u : 0u;\n",
    "}\n",
    "\n",
    "vec4 ism_scaled(vec4 sum, uint pattern) { return sum * (float(pattern) / COHSM_PI); }\n",
    "\n",
    "// ---- near points ----\n",
    "\n",
    "struct ism_near_point {\n",
    "    vec3  position, normal, flux;\n",
    "    float side, reach;\n",
    "    uint  vpl;                  // by whose map it is seen\n",
    "};\n",
    "\n",
    "ism_near_point ism_read_near(uint i)\n",
    "{\n",
    "    uint at = glbk_ism_frame.near_points.z + 3u * i;\n",
    "    vec4 a = texelFetch(glbk_ism_vpls, glbk_table_at(at), 0), b = texelFetch(glbk_ism_vpls, glbk_table_at(at + 1u), 0);\n",
    "    vec4 c = texelFetch(glbk_ism_vpls, glbk_table_at(at + 2u), 0);\n",
    "    ism_near_point q;\n",
    "    q.position = a.xyz;\n",
    "    q.side = a.w;\n",
    "    q.normal = b.xyz;\n",
    "    q.reach = b.w;\n",
    "    q.flux = c.xyz;\n",
    "    q.vpl = uint(c.w);\n",
    "    return q;\n",
    "}\n",
    "\n",
    "// By its VPL's map; where that hides, and the point is nearer than the VPL, by the map moved to the point. Lit behind\n",
    "// the VPL. Neither for what faces the point: the backs of bent sheets do.\n",
    "float ism_near_visible(ism_near_point q, vec3 p, vec3 n, vec3 ng, float bias)\n",
    "{\n",
    "    ism_vpl l = ism_read_vpl(q.vpl);\n",
    "    vec3 way = l.position - q.position, d = p - q.position, at = p;\n",
    "    float open = 1.0 - clamp(-2.0 * dot(n, q.normal), 0.0, 1.0), lit = 1.0;\n",
    "    if (!(dot(l.frame[2], p - l.position) > 0.0)) return open;\n",
    "    bool movable = open > 0.0 && dot(d, d) < dot(way, way) && dot(l.frame[2], d) > 0.0;\n",
    "    // a loop, because what is written twice is waited for twice where neighbours differ\n",
    "    while (!(ism_visible(q.vpl, l, at, ng, bias) > 0.0)) {\n",
    "        if (!movable) return 0.0;\n",
    "        movable = false;\n",
    "        at = p + way;\n",
    "        lit = open;\n",
    "    }\n",
    "    return lit;\n",
    "}\n",
    "\n",
    "// How far it stands here for VPLs; 0 where it gives nothing.\n",
    "float ism_near_weight(vec3 position, float reach, vec3 normal, vec3 p, vec3 n)\n",
    "{\n",
    "    vec3 d = position - p;\n",
    "    return dot(n, d) > 0.0 && dot(normal, d) < 0.0 ? ism_nearness(dot(d, d), reach) : 0.0;\n",
    "}\n",
    "\n",
    "// Its kernel by how far it stands here for VPLs; plain without what the square's rule takes off.\n",
    "float ism_near_kernel(ism_near_point q, vec3 p, vec3 n, out float plain)\n",
    "{\n",
    "    vec3 d = q.position - p;\n",
    "    float d2 = dot(d, d), h = ism_near_weight(q.position, q.reach, q.normal, p, n);\n",
    "    plain = 0.0;\n",
    "    if (!(h > 0.0)) return 0.0;\n",
    "    float point = dot(n, d) * -dot(q.normal, d) / (d2 * d2 + 1e-37), k = point;\n",
    "    plain = point;\n",
    "    if (d2 < 9.0 * q.side * q.side) k = ism_patch_kernel(ism_frame_of(q.normal), q.side, d, n, point, plain);\n",
    "    plain *= h;\n",
    "    return k * h;\n",
    "}\n",
    "\n",
    "// Whether it stands for VPLs here.\n",
    "bool ism_near_counts(uint i, vec3 p, vec3 n)\n",
    "{\n",
    "    uint at = glbk_ism_frame.near_points.z + 3u * i;\n",
    "    vec4 a = texelFetch(glbk_ism_vpls, glbk_table_at(at), 0), b = texelFetch(glbk_ism_vpls, glbk_table_at(at + 1u), 0);\n",
    "    return ism_near_weight(a.xyz, b.w, b.xyz, p, n) > 0.0;\n",
    "}\n",
    "\n",
    "// The first of this class from i on in a block of 64 that reaches as far as p: beyond its sphere none does, and 64 is\n",
    "// a whole number of patterns.\n",
    "uint ism_near_block(uint i, uint count, vec3 p)\n",
    "{\n",
    "    for (; i < count; i += 64u) {\n",
    "        vec4 sphere = texelFetch(glbk_ism_vpls, glbk_table_at(glbk_ism_frame.near_points.y + i / 64u), 0);\n",
    "        vec3 d = sphere.xyz - p;\n",
    "        if (dot(d, d) < sphere.w * sphere.w) break;\n",
    "    }\n",
    "    return i;\n",
    "}\n",
    "\n",
    "// What the near points first, first + pattern, ... give, scaled up as VPLs are by ism_scaled. They are looked\n",
    "// for four at a time, and what one costs comes in a loop of its own, because neighbours wait for each other: it is paid\n",
    "// where they have some too, not at every point of any.\n",
    "vec4 ism_gather(vec3 p, vec3 n, vec3 ng, uint first, uint pattern)\n",
    "{\n",
    "    uint count = glbk_ism_frame.near_points.x, i = ism_near_block(first, count, p);\n",
    "    vec4 sum = vec4(0.0);\n",
    "    while (i < count) {\n",
    "        uvec4 found = uvec4(0u);\n",
    "        uint have = 0u;\n",
    "        while (i < count && have < 4u) {\n",
    "            if (ism_near_counts(i, p, n)) found[have++] = i;\n",
    "            i += pattern;\n",
    "            if ((i & 63u) < pattern) i = ism_near_block(i, count, p);\n",
    "        }\n",
    "        for (uint k = 0u; k < have; k++) {\n",
    "            ism_near_point q = ism_read_near(found[k]);\n",
    "            float plain, bright = ism_near_kernel(q, p, n, plain);\n",
    "            if (!(bright > 0.0)) continue;\n",
    "            float lit = (glbk_ism_view.size.w & 1u) != 0u ? 1.0 : ism_near_visible(q, p, n, ng, glbk_ism_view.values.x);\n",
    "            sum += lit * vec4(bright * q.flux, max(plain - bright, 0.0) * ism_luminance(q.flux));\n",
    "        }\n",
    "    }\n",
    "    return ism_scaled(sum, pattern);\n",
    "}\n",
    "\n",
    "// xyz: irradiance by the VPLs first, first + pattern, ... times pattern; w: what the rule near by took off.\n",
    "vec4 ism_light(vec3 p, vec3 n, vec3 ng, uint first, uint pattern)\n",
    "{\n",
    "    uint count = glbk_ism_frame.maps.x;\n",
    "    float most = glbk_ism_view.values.y;\n",
    "    vec4 sum = vec4(0.0);\n",
    "#if ISM_NEAR == 4\n",
    "    uint used = ism_used(first, pattern);\n",
    "    float all = 0.0;\n",
    "    for (uint v = first; v < count; v += pattern) all += ism_unshadowed(ism_read_vpl(v), p, n);\n",
    "    most *= used > 0u ? all / float(used) : 0.0;\n",
    "#endif\n",
    "    for (uint v = first; v < count; v += pattern) ism_add(sum, v, ism_read_vpl(v), p, n, ng, most);\n",
    "#if ISM_NEAR == 6\n",
    "    return ism_scaled(sum, pattern) + ism_gather(p, n, ng, first, pattern);\n",
    "#else\n",
    "    return ism_scaled(sum, pattern);\n",
    "#endif\n",
    "}\n"
};

static const char *const glbk__glsl_lib_ism_map_glsl[] = {
    "// ism_map - the hemisphere about +z and the unit square, and the planes of surfels. C twins: ism.h.\n",
    "// uses: cohsm_math\n",
    "#define ISM_PROJECTION_COSINE 1u\n",
    "#define ISM_PROJECTION_PARABOLOID 2u\n",
    "#define ISM_PROJECTION_OCTAHEDRAL 3u\n",
    "#define ISM_PROJECTION_LOBE 4u\n",
    "#define ISM_FAR 1e30\n",
    "// Of all VPLs, so that no program holds the code of the others; lobes of exponent 1 have the cosine's.\n",
    "#ifndef ISM_PROJECTION\n",
    "#define ISM_PROJECTION 1\n",
    "#endif\n",
    "\n",
    "uint ism_projection_of(float exponent)\n",
    "{\n",
    "#if ISM_PROJECTION == 4\n",
    "    return exponent == 1.0 ? ISM_PROJECTION_COSINE : ISM_PROJECTION_LOBE;\n",
    "#else\n",
    "    return uint(ISM_PROJECTION);\n",
    "#endif\n",
    "}\n",
    "\n",
    "// 1 - x^y for x in 0..1, to the last digits where that is small.\n",
    "float ism_power_gap(float x, float y)\n",
    "{\n",
    "    if (!(x > 1.18e-38)) return 1.0;\n",
    "    float t = y * cohsm_log(min(x, 1.0));\n",
    "    if (t < -0.35) return 1.0 - cohsm_exp(t);\n",
    "    return -t * (1.0 + t * (0.5 + t * (0.166666667 + t * (0.0416666667 + t * (0.00833333333 + t * (0.00138888889 +\n",
    "           t * 0.000198412698))))));\n",
    "}\n",
    "\n",
    "vec3 ism_map_direction(uint projection, float exponent, vec2 uv)\n",
    "{\n",
    "    vec2 ab = 2.0 * uv - 1.0;\n",
    "    if (projection == ISM_PROJECTION_PARABOLOID) {\n",
    "        float r2 = dot(ab, ab);\n",
    "        return vec3(2.0 * ab, 1.0 - r2) / (1.0 + r2);\n",
    "    }\n",
    "    if (projection == ISM_PROJECTION_OCTAHEDRAL) {\n",
    "        vec2 p = 0.5 * vec2(ab.x + ab.y, ab.x - ab.y);\n",
    "        return cohsm_normalize(vec3(p, 1.0 - abs(p.x) - abs(p.y)));\n",
    "    }\n",
    "    float e = projection == ISM_PROJECTION_LOBE ? exponent : 1.0, r = max(abs(ab.x), abs(ab.y));\n",
    "    float s = max(1.0 - r * r, 0.0), z = e == 1.0 ? sqrt(s) : cohsm_pow(s, 1.0 / (e + 1.0));\n",
    "    float sine = e == 1.0 ? r : sqrt(ism_power_gap(s, 2.0 / (e + 1.0)));\n",
    "    return vec3(cohsm_concentric(uv) * (r > 1e-12 ? sine / r : 1.0), z);\n",
    "}\n",
    "\n",
    "// false: at or below the horizon.\n",
    "bool ism_map_coordinates(uint projection, float exponent, vec3 w, out vec2 uv)\n",
    "{\n",
    "    vec2 ab;\n",
    "    uv = vec2(0.0);\n",
    "    if (!(w.z > 0.0)) return false;\n",
    "    if (projection == ISM_PROJECTION_PARABOLOID) {\n",
    "        ab = w.xy / (1.0 + w.z);\n",
    "    } else if (projection == ISM_PROJECTION_OCTAHEDRAL) {\n",
    "        ab = vec2(w.x + w.y, w.x - w.y) / (abs(w.x) + abs(w.y) + w.z);\n",
    "    } else {\n",
    "        float e = projection == ISM_PROJECTION_LOBE ? exponent : 1.0;\n",
    "        if (e != 1.0) {\n",
    "            float sine = sqrt(dot(w.xy, w.xy));\n",
    "            w.xy *= sine > 1e-12 ? sqrt(ism_power_gap(w.z, e + 1.0)) / sine : 1.0;\n",
    "        }\n",
    "        uv = cohsm_disc_square(w.xy);\n",
    "        return true;\n",
    "    }\n",
    "    uv = clamp(0.5 * ab + 0.5, 0.0, 1.0);\n",
    "    return true;\n",
    "}\n",
    "\n",
    "// An axis of a tile of `size` texels a side, `rim` of them outside of its window: how many lie below it (all where it\n",
    "// is not worth its rim), and what share of the square a texel has below, in and above it. cut: 64ths of the square\n",
    "// below and above.\n",
    "vec4 ism_axis(uvec2 cut, uint size, uint rim)\n",
    "{\n",
    "    uint rest = cut.x + cut.y;\n",
    "    if (!(rest * size > rim * 64u) || rest >= 64u) return vec4(float(size), 1.0 / float(size), 1.0, 1.0);\n",
    "    // whole numbers divided as floats, which lanes do side by side: with the half no quotient is near a whole number\n",
    "    float a = floor((float(2u * rim * cut.x + rest) + 0.5) / float(2u * rest)), most = float(rim);\n",
    "    if (cut.x != 0u && a == 0.0) a = 1.0;\n",
    "    if (cut.y != 0u && a == most) a = most - 1.0;\n",
    "    vec3 share = vec3(cut.x, 64u - rest, cut.y) / (64.0 * max(vec3(a, float(size - rim), most - a), 1.0));\n",
    "    return vec4(a, a > 0.0 ? share.x : 1.0, share.y, a < most ? share.z : 1.0);\n",
    "}\n",
    "\n",
    "// From 0..1 of the square to the texels of such an axis, and back: linear below, in and above the window.\n",
    "float ism_zoom_axis(vec4 axis, float size, float rim, float u)\n",
    "{\n",
    "    float low = axis.x * axis.y, high = 1.0 - (rim - axis.x) * axis.w;\n",
    "    vec3 part = u < low ? vec3(0.0, u, axis.y) : u < high ? vec3(axis.x, u - low, axis.z) : vec3(size, u - 1.0, axis.w);\n",
    "    return clamp(part.x + part.y / part.z, 0.0, size);\n",
    "}\n",
    "\n",
    "float ism_unzoom_axis(vec4 axis, float size, float rim, float x)\n",
    "{\n",
    "    float u = x < axis.x ? x * axis.y : x < axis.x + size - rim ? axis.x * axis.y + (x - axis.x) * axis.z\n",
    "                                                                : 1.0 - (size - x) * axis.w;\n",
    "    return clamp(u, 0.0, 1.0);\n",
    "}\n",
    "\n",
    "// Both axes; window: ism_vpl.window.\n",
    "void ism_axes(uint window, uint size, uint rim, out vec4 across, out vec4 down)\n",
    "{\n",
    "    uvec4 cut = uvec4(window, window >> 6, window >> 12, window >> 18) & 63u;\n",
    "    across = ism_axis(cut.xz, size, rim);\n",
    "    down = ism_axis(cut.yw, size, rim);\n",
    "}\n",
    "\n",
    "vec2 ism_zoom(uint window, uint size, uint rim, vec2 uv)\n",
    "{\n",
    "    vec4 across, down;\n",
    "    ism_axes(window, size, rim, across, down);\n",
    "    vec2 s = vec2(size, rim);\n",
    "    return vec2(ism_zoom_axis(across, s.x, s.y, uv.x), ism_zoom_axis(down, s.x, s.y, uv.y));\n",
    "}\n",
    "\n",
    "vec2 ism_unzoom(uint window, uint size, uint rim, vec2 at)\n",
    "{\n",
    "    vec4 across, down;\n",
    "    ism_axes(window, size, rim, across, down);\n",
    "    vec2 s = vec2(size, rim);\n",
    "    return vec2(ism_unzoom_axis(across, s.x, s.y, at.x), ism_unzoom_axis(down, s.x, s.y, at.y));\n",
    "}\n",
    "\n",
    "// Columns x, y, z; v * frame is v in it.\n",
    "mat3 ism_frame_of(vec3 z)\n",
    "{\n",
    "    vec3 x, y;\n",
    "    cohsm_basis(z, x, y);\n",
    "    return mat3(x, y, z);\n",
    "}\n",
    "\n",
    "// Depth of a surfel's plane in direction w, or at place w of a sky's map; 0 where they do not meet.\n",
    "float ism_plane_depth(bool sky, vec3 g, vec3 w)\n",
    "{\n",
    "    float s = dot(g, w);\n",
    "    if (sky) return max(s, 0.0);\n",
    "    return s > 1e-20 ? 1.0 / s : 0.0;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_ism_push_glsl[] = {
    "// ism_push - texels without a surfel. The program has ism_pulled: what ism_pull said of a cell of the atlas.\n",
    "// uses: ism_fill\n",
    "int ism_pulled(int level, ivec2 cell);\n",
    "\n",
    "// 1 + index; squared distances; sectors\n",
    "struct ism_near { int first, second, least, next; uint found, close, beyond; };\n",
    "\n",
    "// The 3 x 3 cells about the texel.\n",
    "void ism_look(int level, ivec2 at, inout ism_near n)\n",
    "{\n",
    "    int size = int(glbk_ism_frame.maps.y), half_size = size >> level;\n",
    "    ivec2 local = at & (size - 1), cell = local >> level, origin = (at >> level) - cell;\n",
    "    for (int y = cell.y - 1; y <= cell.y + 1; y++)\n",
    "        for (int x = cell.x - 1; x <= cell.x + 1; x++) {\n",
    "            if (x < 0 || y < 0 || x >= half_size || y >= half_size) {\n",
    "                n.beyond |= ism_sector(ivec2(x, y) - cell);\n",
    "                continue;\n",
    "            }\n",
    "            int there = ism_pulled(level, origin + ivec2(x, y));\n",
    "            if (there == 0) continue;\n",
    "            ivec2 d = ivec2((there - 1) % size, (there - 1) / size) - local;\n",
    "            int d2 = d.x * d.x + d.y * d.y;\n",
    "            n.found |= ism_sector(d);\n",
    "            if (n.first == 0 || d2 < n.least) {\n",
    "                if (n.first != 0 && n.first != there) {\n",
    "                    n.second = n.first;\n",
    "                    n.next = n.least;\n",
    "                }\n",
    "                n.first = there;\n",
    "                n.least = d2;\n",
    "            } else if (n.first != there && (n.second == 0 || d2 < n.next)) {\n",
    "                n.second = there;\n",
    "                n.next = d2;\n",
    "            }\n",
    "        }\n",
    "    if (level == 1) n.close = n.found;\n",
    "}\n",
    "\n",
    "// The first one's depth, or its plane's here, whichever would have foretold the second better. No depths are mixed.\n",
    "float ism_push(ism_grid grid, ivec2 local, ivec2 first, ivec2 second, ivec2 origin)\n",
    "{\n",
    "    vec4 a = ism_surfel_at(origin + first), b = ism_surfel_at(origin + second);\n",
    "    float t = ism_plane_depth(grid.exponent < 0.0, a.xyz, ism_texel_direction(grid, local));\n",
    "    float there = ism_plane_depth(grid.exponent < 0.0, a.xyz, ism_texel_direction(grid, second));\n",
    "    if (abs(a.w - b.w) <= abs(there - b.w)) return a.w;\n",
    "    return t > 0.5 * a.w && t < 2.0 * a.w ? t : a.w;\n",
    "}\n",
    "\n",
    "// The depth of texel `at` of the atlas, in a tile of that kind, from the nearest two that keep their surfels once it is\n",
    "// surrounded; or ISM_FAR.\n",
    "float ism_filled(ism_grid grid, ivec2 at)\n",
    "{\n",
    "    int size = int(glbk_ism_frame.maps.y);\n",
    "    ivec2 local = at & (size - 1);\n",
    "    ism_near n = ism_near(0, 0, 0, 0, 0u, 0u, 0u);\n",
    "    for (int level = 1; level <= int(glbk_ism_frame.points.z); level++) {\n",
    "        if (n.second != 0 && ism_surrounded(n.found, n.close, n.beyond)) break;\n",
    "        ism_look(level, at, n);\n",
    "    }\n",
    "    if (n.second == 0 || !ism_surrounded(n.found, n.close, n.beyond)) return ISM_FAR;\n",
    "    return ism_push(grid, local, ivec2((n.first - 1) % size, (n.first - 1) / size),\n",
    "                    ivec2((n.second - 1) % size, (n.second - 1) / size), at - local);\n",
    "}\n"
};

static const char *const glbk__glsl_lib_ism_view_glsl[] = {
    "// glbk_ism_view, uniform block\n",
    "layout(std140) uniform glbk_ism_view_block {\n",
    "    uvec4 size;\n",
    "    vec4 values;\n",
    "} glbk_ism_view;\n"
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

static const char *const glbk__glsl_lib_rsm_access_glsl[] = {
    "// rsm_access - what the files rsm_* ask of a program, from what glbk_rsm_bind binds.\n",
    "// uses: rsm_bindings rsm_map\n",
    "// Image k of texel t.xy of face t.z: 0 position and depth, 1 normal and material, 2 flux and area.\n",
    "#define RSM_TEXEL(t, k) texelFetch(glbk_rsm_texels, ivec3((t).xy, 3 * (t).z + (k)), 0)\n",
    "// Running sums of flux: in the row up to texel x, and of rows up to row y of its face.\n",
    "#define RSM_ROW_SUM(t) uintBitsToFloat(texelFetch(glbk_rsm_sums, t, 0).x)\n",
    "#define RSM_ROWS_SUM(y, face) uintBitsToFloat(texelFetch(glbk_rsm_rows, ivec3(y, 0, face), 0).x)\n",
    "// Number i of the list: 0 position and bound, 1 normal and density (MIXED) or squared distance that is near, 2 flux and\n",
    "// texel, 3 light and material.\n",
    "#define RSM_LISTED(i, k) texelFetch(glbk_rsm_lights, ivec3(int((i) & 1023u), int((i) >> 10), k), 0)\n",
    "#define RSM_PATTERN(i) texelFetch(glbk_rsm_pattern, ivec2(int((i) & 1023u), int((i) >> 10)), 0).xyz\n",
    "#ifndef RSM_LIGHT           // lib/rsm_chunk.glsl has chunks of both in shared memory\n",
    "#define RSM_LIGHT(i, k) RSM_LISTED(i, k)\n",
    "#define RSM_POINT_AT(i) RSM_PATTERN(i)\n",
    "#endif\n",
    "#define RSM_MATERIAL(i) texelFetch(glbk_rsm_materials, ivec2(int(i), 0), 0)\n",
    "#define RSM_SEEN(at, k) texelFetch(glbk_rsm_seen, ivec3(at, k), 0)\n"
};

static const char *const glbk__glsl_lib_rsm_bindings_glsl[] = {
    "// rsm_bindings - from the lists GLBK_RSM_* of gl_backend.h.\n",
    "uniform usampler2DArray glbk_rsm_texels;\n",
    "uniform usampler2DArray glbk_rsm_sums;\n",
    "uniform usampler2DArray glbk_rsm_rows;\n",
    "uniform usampler2DArray glbk_rsm_lights;\n",
    "uniform sampler2D glbk_rsm_pattern;\n",
    "uniform sampler2D glbk_rsm_noise;\n",
    "uniform sampler2D glbk_rsm_materials;\n",
    "uniform usampler2DArray glbk_rsm_seen;\n",
    "uniform usampler2DArray glbk_rsm_before;\n",
    "uniform glbk_color_sampler glbk_rsm_sum;\n",
    "uniform glbk_color_sampler glbk_rsm_states;\n",
    "uniform glbk_color_sampler glbk_rsm_coarse;\n",
    "uniform glbk_color_sampler glbk_rsm_history;\n",
    "uniform sampler2D glbk_rsm_motion;\n",
    "uniform sampler2D glbk_rsm_albedo_map;\n",
    "#if __VERSION__ >= 430\n",
    "layout(std430, binding = 0) coherent buffer glbk_rsm_counts_storage { uint glbk_rsm_counts[]; };\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(std430, binding = 1) readonly buffer glbk_rsm_items_storage { uint glbk_rsm_items[]; };\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(std430, binding = 2) writeonly buffer glbk_rsm_left_storage { uint glbk_rsm_left[]; };\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(std430, binding = 3) writeonly buffer glbk_rsm_wanted_storage { uint glbk_rsm_wanted[]; };\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(std430, binding = 4) coherent buffer glbk_rsm_marks_storage { uint glbk_rsm_marks[]; };\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(rgba32f, binding = 0) restrict uniform image2D glbk_rsm_picture;\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(rgba32f, binding = 1) restrict uniform image2D glbk_rsm_nodes;\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(r32ui, binding = 2) restrict writeonly uniform uimage2DArray glbk_rsm_running;\n",
    "#endif\n"
};

static const char *const glbk__glsl_lib_rsm_bounce_glsl[] = {
    "// rsm_bounce - bounced light of receivers of the G-buffer.\n",
    "// uses: rsm_screen rsm_gather\n",
    "// Cosine and sine of the rotation of a pixel's pattern.\n",
    "vec2 rsm_turn(ivec2 at)\n",
    "{\n",
    "    uint noise = glbk_rsm_frame.counts.w;\n",
    "    if (noise == 0u) return vec2(1.0, 0.0);\n",
    "    float angle = 2.0 * RSM_PI * texelFetch(glbk_rsm_noise, ivec2(uvec2(at) % noise), 0).x;\n",
    "    return vec2(cos(angle), sin(angle));\n",
    "}\n",
    "\n",
    "// Lights from .. to - 1 of the bound list; points first, first + step, ... of the bound pattern about the receiver.\n",
    "vec3 rsm_listed(rsm_lamp l, rsm_receiver r, uint from, uint to)\n",
    "{\n",
    "    return rsm_gather_list(l, r.position, r.normal, from, to, glbk_rsm_frame.pick.w != 0u, glbk_rsm_frame.pattern.y);\n",
    "}\n",
    "\n",
    "vec3 rsm_about(rsm_lamp l, rsm_receiver r, vec2 turn, uint first, uint step, uint count)\n",
    "{\n",
    "    return rsm_gather_about(l, r.position, r.normal, glbk_rsm_frame.pattern.x, turn, first, step, count,\n",
    "                            glbk_rsm_frame.limits, glbk_rsm_frame.pick.w != 0u, glbk_rsm_frame.pattern.y,\n",
    "                            glbk_rsm_frame.pattern.z, glbk_rsm_frame.surfaces.x);\n",
    "}\n",
    "\n",
    "// Bounced light of pixel `at` from the bound list, map and pattern.\n",
    "vec3 rsm_bounce(rsm_receiver r, ivec2 at)\n",
    "{\n",
    "    uint k = glbk_rsm_frame.counts.y, set = rsm_set(at), base = set * glbk_rsm_frame.range.z;\n",
    "    rsm_lamp l = rsm_bound();\n",
    "    vec3 sum = vec3(0.0);\n",
    "    if (glbk_rsm_frame.range.y > glbk_rsm_frame.range.x)\n",
    "        sum = rsm_listed(l, r, base + glbk_rsm_frame.range.x, base + glbk_rsm_frame.range.y);\n",
    "    if (glbk_rsm_frame.counts.z > 0u) sum += rsm_about(l, r, rsm_turn(at), set, k * k, glbk_rsm_frame.counts.z);\n",
    "    return sum / RSM_PI;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_rsm_bound_glsl[] = {
    "// rsm_bound - the light whose map glbk_rsm_bind bound.\n",
    "// uses: rsm_map\n",
    "rsm_lamp rsm_bound()\n",
    "{\n",
    "    return rsm_lamp(glbk_rsm_light.position.xyz, glbk_rsm_light.right.xyz, glbk_rsm_light.up.xyz,\n",
    "                    glbk_rsm_light.axis.xyz, glbk_rsm_light.value.xyz, glbk_rsm_light.position.w,\n",
    "                    glbk_rsm_light.axis.w, glbk_rsm_light.value.w, int(glbk_rsm_light.up.w),\n",
    "                    int(glbk_rsm_light.right.w));\n",
    "}\n"
};

static const char *const glbk__glsl_lib_rsm_chunk_glsl[] = {
    "// rsm_chunk - lights of the list and points of the pattern that a work group reads together, in shared memory: for\n",
    "// compute programs, before rsm_gather, whose numbers then count from the chunk's first.\n",
    "#define RSM_CHUNK 64u               // lights, as many as the group has invocations; or four times as many points\n",
    "shared uvec4 rsm_chunk[4u * RSM_CHUNK];\n",
    "#define RSM_LIGHT(i, k) rsm_chunk[RSM_CHUNK * uint(k) + (i)]\n",
    "#define RSM_POINT_AT(i) uintBitsToFloat(rsm_chunk[i].xyz)\n"
};

static const char *const glbk__glsl_lib_rsm_direct_glsl[] = {
    "// rsm_direct - a light itself by its map: percentage-closer filter, bias by slope. uses a bound map's RSM_TEXEL\n",
    "// uses: rsm_access rsm_bound\n",
    "// Irradiance of a light of value 1 without shadow; 0 outside a cone or behind a patch.\n",
    "float rsm_unshadowed(rsm_lamp l, vec3 p, vec3 n)\n",
    "{\n",
    "    vec3 to = rsm_to_light(l, p), d = p - l.position;\n",
    "    float d2 = dot(d, d), cosine = dot(n, to), along = -dot(l.axis, to);\n",
    "    if (!(cosine > 0.0)) return 0.0;\n",
    "    if (l.kind == RSM_SUN) return cosine;\n",
    "    if (!(d2 > 0.0)) return 0.0;\n",
    "    if (l.kind == RSM_SPOT && !(along >= l.cos_half)) return 0.0;\n",
    "    if (l.kind == RSM_SQUARE_SPOT) {\n",
    "        vec3 q = rsm_to_face(l, 0, p);\n",
    "        if (!(q.z > 0.0 && abs(q.x) <= 1.0 && abs(q.y) <= 1.0)) return 0.0;\n",
    "    }\n",
    "    if (l.kind == RSM_PATCH) cosine *= max(along, 0.0);\n",
    "    return cosine / d2;\n",
    "}\n",
    "\n",
    "// Lit share of taps x taps texels about p, weighted as a box moved by fractions of a texel; 2 taps: bilinear.\n",
    "float rsm_pcf(rsm_lamp l, vec3 p, float cosine, int taps, float bias, float slope_bias)\n",
    "{\n",
    "    int face = rsm_face_of_direction(l, p - l.position), size = int(l.size);\n",
    "    if (face >= l.faces) return 0.0;\n",
    "    vec3 q = rsm_to_face(l, face, p);\n",
    "    if (l.kind != RSM_SUN && !(q.z > 0.0)) return 0.0;\n",
    "    if (!(abs(q.x) <= 1.0 && abs(q.y) <= 1.0)) return l.kind == RSM_SUN ? 1.0 : 0.0;\n",
    "    float texel = 2.0 / l.size * l.extent * (l.kind == RSM_SUN ? 1.0 : q.z);\n",
    "    float slope = cosine < 1.0 ? min(sqrt(1.0 - cosine * cosine) / max(cosine, 0.1), 10.0) : 0.0;\n",
    "    float reach = q.z - texel * (bias + slope_bias * slope * 0.7072 * float(taps));\n",
    "    vec2 first = (q.xy * 0.5 + 0.5) * l.size - 0.5 * float(taps - 1), f = first - floor(first);\n",
    "    float sum = 0.0, total = 0.0;\n",
    "    for (int j = 0; j < taps; j++)\n",
    "        for (int i = 0; i < taps; i++) {\n",
    "            vec2 w = vec2(i == 0 ? 1.0 - f.x : i == taps - 1 ? f.x : 1.0,\n",
    "                          j == 0 ? 1.0 - f.y : j == taps - 1 ? f.y : 1.0);\n",
    "            float weight = taps == 1 ? 1.0 : w.x * w.y;\n",
    "            ivec3 t = ivec3(clamp(ivec2(floor(first)) + ivec2(i, j), ivec2(0), ivec2(size - 1)), face);\n",
    "            total += weight;\n",
    "            if (reach <= uintBitsToFloat(RSM_TEXEL(t, 0).w)) sum += weight;\n",
    "        }\n",
    "    return total > 0.0 ? sum / total : 0.0;\n",
    "}\n",
    "\n",
    "// Irradiance of p from the bound light.\n",
    "vec3 rsm_direct(rsm_lamp l, vec3 p, vec3 n, int taps, float bias, float slope_bias)\n",
    "{\n",
    "    float light = rsm_unshadowed(l, p, n);\n",
    "    if (light > 0.0) light *= rsm_pcf(l, p, dot(n, rsm_to_light(l, p)), taps, bias, slope_bias);\n",
    "    return light * l.value;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_rsm_drawn_glsl[] = {
    "// glbk_rsm_drawn, uniform block\n",
    "layout(std140) uniform glbk_rsm_drawn_block {\n",
    "    mat4 world;\n",
    "    mat4 clip;\n",
    "    vec4 albedo;\n",
    "    vec4 eye;\n",
    "    vec4 range;\n",
    "    uvec4 kinds;\n",
    "} glbk_rsm_drawn;\n"
};

static const char *const glbk__glsl_lib_rsm_frame_glsl[] = {
    "// glbk_rsm_frame, uniform block\n",
    "layout(std140) uniform glbk_rsm_frame_block {\n",
    "    uvec4 counts;\n",
    "    uvec4 range;\n",
    "    uvec4 pick;\n",
    "    uvec4 grid;\n",
    "    uvec4 mode;\n",
    "    vec4 pattern;\n",
    "    vec4 limits;\n",
    "    vec4 tests;\n",
    "    uvec4 lists;\n",
    "    vec4 surfaces;\n",
    "} glbk_rsm_frame;\n"
};

static const char *const glbk__glsl_lib_rsm_gather_glsl[] = {
    "// rsm_gather - bounced light of a receiver: from the list of pixel lights, and from texels about its projection.\n",
    "// Defines: RSM_SURFACES=1, where near_field makes surfaces of near texels; 0, the default: all lights are points.\n",
    "// uses: rsm_pick\n",
    "#ifndef RSM_SURFACES\n",
    "#define RSM_SURFACES 0\n",
    "#endif\n",
    "// Equation (1) without flux: cos cos / d^2, cosines times d over d^4. Both must exceed the rounding of positions, so\n",
    "// that a plane does not light itself (T40).\n",
    "float rsm_near = 0.0;     // 1 / squared distance of the nearest light so far that is not edge-on, for interpolation\n",
    "\n",
    "float rsm_form(vec3 p, vec3 n, vec3 light, vec3 light_normal, float bound)\n",
    "{\n",
    "    vec3 d = light - p, most = max(abs(p), abs(light));\n",
    "    float rounding = 4e-7 * max(max(most.x, most.y), most.z), inverse = 1.0 / max(dot(d, d), 1e-18);\n",
    "    float receives = max(dot(n, d) - rounding, 0.0), emits = max(-dot(light_normal, d) - rounding, 0.0);\n",
    "    float form = (receives * inverse) * (emits * inverse);\n",
    "    if (form * dot(d, d) > 1e-3) rsm_near = max(rsm_near, inverse);\n",
    "    return min(form, bound);\n",
    "}\n",
    "\n",
    "#if RSM_SURFACES\n",
    "// Half the sides of the surface under a texel at p: the cross section of its beam, along the beam onto the plane of n.\n",
    "// Their parallelogram has rsm_area's area, since grazing ones are bounded alike, along the light.\n",
    "void rsm_texel_sides(rsm_lamp l, int face, vec3 p, vec3 n, out vec3 side, out vec3 other)\n",
    "{\n",
    "    vec3 a, d;\n",
    "    float scale = l.extent / l.size;\n",
    "    rsm_face_frame(l, face, side, other, a);\n",
    "    d = a;\n",
    "    if (l.kind != RSM_SUN) {\n",
    "        float depth = dot(p - l.position, a);\n",
    "        d = (p - l.position) / depth;\n",
    "        scale *= depth;\n",
    "    }\n",
    "    float facing = dot(d, n), least = 0.05 * length(d), bounded = max(abs(facing), least) * (facing < 0.0 ? -1.0 : 1.0);\n",
    "    vec3 along = d - n * facing;\n",
    "    vec2 off = vec2(dot(side, n), dot(other, n)), stretched = off / bounded;\n",
    "    if (abs(facing) < least)\n",
    "        stretched += vec2(dot(side, along), dot(other, along)) * ((1.0 - abs(facing) / least) / dot(along, along));\n",
    "    side = (side - n * off.x - along * stretched.x) * scale;\n",
    "    other = (other - n * off.y - along * stretched.y) * scale;\n",
    "}\n",
    "\n",
    "// An edge's share of Lambert's sum: angle(a, b) n . (b x a) / |b x a|.\n",
    "float rsm_edge(vec3 n, vec3 a, vec3 b)\n",
    "{\n",
    "    vec3 c = cross(b - a, a);\n",
    "    float size = length(c);\n",
    "    return size > 0.0 ? atan(size, dot(a, b)) * (dot(n, c) / size) : 0.0;\n",
    "}\n",
    "\n",
    "float rsm_clipped_edge(vec3 n, vec3 a, vec3 b, inout vec3 leave, inout vec3 come)\n",
    "{\n",
    "    float ha = dot(n, a), hb = dot(n, b);\n",
    "    if (!(ha > 0.0) && !(hb > 0.0)) return 0.0;\n",
    "    if (!(ha > 0.0 && hb > 0.0)) {\n",
    "        vec3 at = a + (b - a) * (ha / (ha - hb));\n",
    "        if (ha > 0.0) b = leave = at;\n",
    "        else a = come = at;\n",
    "    }\n",
    "    return rsm_edge(n, a, b);\n",
    "}\n",
    "\n",
    "// Integral of cos cos / d^2 over the parallelogram c +- u +- v, seen from the origin and clipped at the horizon of n:\n",
    "// pi times the form factor (Baum, Rushmeier and Winget 1989). The horizon cuts it once at most: where it leaves and\n",
    "// where it comes back are joined. No loop, since it is called in one: llvmpipe counts the rounds of all of them\n",
    "// together.\n",
    "float rsm_form_of(vec3 n, vec3 c, vec3 u, vec3 v)\n",
    "{\n",
    "    vec3 p = c - u - v, q = c + u - v, r = c + u + v, s = c - u + v, leave = c, come = c;\n",
    "    float sum = rsm_clipped_edge(n, p, q, leave, come) + rsm_clipped_edge(n, q, r, leave, come);\n",
    "    sum += rsm_clipped_edge(n, r, s, leave, come) + rsm_clipped_edge(n, s, p, leave, come);\n",
    "    return 0.5 * abs(sum + rsm_edge(n, leave, come));\n",
    "}\n",
    "#endif\n",
    "\n",
    "// rsm_form where the light is a texel of a face: nearer than the root of near2 the mean over the surface that it is. To\n",
    "// receivers that face it nearer than half its side to its plane no more than a point, by degrees: so lie the backs of\n",
    "// bent sheets, through which the parallelogram reaches.\n",
    "float rsm_texel_form(rsm_lamp l, vec3 p, vec3 n, int face, vec3 light, vec3 light_normal, float bound, float near2)\n",
    "{\n",
    "    float form = rsm_form(p, n, light, light_normal, bound);\n",
    "#if RSM_SURFACES\n",
    "    vec3 d = light - p, most = max(abs(p), abs(light)), u, v;\n",
    "    float height = -dot(light_normal, d), d2 = dot(d, d), facing = -2.0 * dot(n, light_normal);\n",
    "    if (!(d2 < near2)) return form;\n",
    "    if (!(height > 4e-7 * max(max(most.x, most.y), most.z))) return 0.0;\n",
    "    rsm_texel_sides(l, face, light, light_normal, u, v);\n",
    "    float area = 4.0 * length(cross(u, v)), point = max(dot(n, d) / d2, 0.0) * (height / d2);\n",
    "    form = area > 0.0 ? rsm_form_of(n, d, u, v) / area : 0.0;\n",
    "    if (form > point && facing > 0.0 && 4.0 * height * height < area)\n",
    "        form += min(facing, 1.0) * (1.0 - 2.0 * height / sqrt(area)) * (point - form);\n",
    "    form = min(form, bound);\n",
    "#endif\n",
    "    return form;\n",
    "}\n",
    "\n",
    "// The glossy part towards p: a Phong lobe about the mirrored direction of the light, of energy `specular`.\n",
    "vec3 rsm_gloss(rsm_lamp l, vec3 p, vec3 light, vec3 light_normal, float form, vec3 incident, vec4 material)\n",
    "{\n",
    "    vec3 to = rsm_to_light(l, light), mirror = 2.0 * dot(light_normal, to) * light_normal - to, d = p - light;\n",
    "    float c = dot(mirror, d) / max(sqrt(dot(d, d)), 1e-9);\n",
    "    if (!(c > 0.0)) return vec3(0.0);\n",
    "    return incident * material.xyz * (0.5 * (material.w + 2.0) * pow(min(c, 1.0), material.w)) * form;\n",
    "}\n",
    "\n",
    "float rsm_bound_of(float area, float limit_clamp, float near_limit)\n",
    "{\n",
    "    float bound = limit_clamp > 0.0 ? limit_clamp : 3.0e38;\n",
    "    return near_limit > 0.0 && area > 0.0 ? min(bound, near_limit * RSM_PI / area) : bound;\n",
    "}\n",
    "\n",
    "// A texel's place: in the unit square, or on the sphere of diameter 1.\n",
    "vec3 rsm_mixed_place(rsm_lamp l, ivec3 t)\n",
    "{\n",
    "    vec2 q = vec2(rsm_texel_centre(l, t.x), rsm_texel_centre(l, t.y));\n",
    "    vec3 r, u, a;\n",
    "    if (l.faces == 1) return vec3(q * 0.5 + 0.5, 0.0);\n",
    "    rsm_face_frame(l, t.z, r, u, a);\n",
    "    return rsm_normalize(a + r * q.x + u * q.y) * 0.5;\n",
    "}\n",
    "\n",
    "// Where patterns about p have their centre: in the unit square, or a direction, with its frame.\n",
    "vec3 rsm_centre_of(rsm_lamp l, vec3 p, bool inside, out vec3 right, out vec3 up)\n",
    "{\n",
    "    right = up = vec3(0.0);\n",
    "    if (l.faces != 1) {\n",
    "        vec3 c = rsm_normalize(p - l.position);\n",
    "        if (!(dot(c, c) > 0.25)) c = l.axis;\n",
    "        float s = c.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (s + c.z), b = c.x * c.y * a;\n",
    "        right = vec3(1.0 + s * c.x * c.x * a, s * b, -s * c.x);\n",
    "        up = vec3(b, s + c.y * c.y * a, -c.y);\n",
    "        return c;\n",
    "    }\n",
    "    vec3 q = rsm_to_face(l, 0, p);\n",
    "    if (l.kind != RSM_SUN && !(q.z > 0.0)) q = vec3(0.0);\n",
    "    q = vec3(q.xy * 0.5 + 0.5, 0.0);\n",
    "    return inside ? vec3(clamp(q.xy, 0.02, 0.98), 0.0) : q;\n",
    "}\n",
    "\n",
    "// Which texel is under a sample of a pattern about the receiver, and how many texels' worth it stands for. turn: cosine\n",
    "// and sine of the pixel's rotation. r_max 0: up to the map's border. false: outside.\n",
    "bool rsm_place_sample(rsm_lamp l, float r_max, vec3 centre, vec3 right, vec3 up, vec3 point, vec2 turn, out ivec3 t,\n",
    "                      out float weight)\n",
    "{\n",
    "    vec2 q = vec2(point.x * turn.x - point.y * turn.y, point.x * turn.y + point.y * turn.x);\n",
    "    int size = int(l.size);\n",
    "    t = ivec3(0);\n",
    "    weight = 0.0;\n",
    "    if (l.faces == 1) {\n",
    "        float r = r_max;\n",
    "        if (!(r > 0.0)) {\n",
    "            float len = length(q);\n",
    "            vec2 d = len > 0.0 ? q / len : vec2(0.0), room;\n",
    "            room.x = abs(d.x) > 1e-9 ? (d.x > 0.0 ? 1.0 - centre.x : centre.x) / abs(d.x) : 4.0;\n",
    "            room.y = abs(d.y) > 1e-9 ? (d.y > 0.0 ? 1.0 - centre.y : centre.y) / abs(d.y) : 4.0;\n",
    "            r = min(room.x, room.y);\n",
    "        }\n",
    "        weight = point.z * r * r * l.size * l.size;\n",
    "        q = (centre.xy + r * q) * l.size;\n",
    "        if (!(r_max > 0.0)) q = clamp(q, vec2(0.0), vec2(l.size - 0.5));\n",
    "        if (any(lessThan(q, vec2(0.0))) || any(greaterThanEqual(q, vec2(l.size)))) return false;\n",
    "        t = ivec3(ivec2(q), 0);\n",
    "        return true;\n",
    "    }\n",
    "    float r = r_max > 0.0 && r_max < 1.0 ? r_max : 1.0;\n",
    "    q *= r;\n",
    "    float s = dot(q, q), k = 2.0 * sqrt(max(1.0 - s, 0.0));\n",
    "    vec3 d = centre * (1.0 - 2.0 * s) + right * (q.x * k) + up * (q.y * k), a, fr, fu;\n",
    "    t.z = rsm_face_of_direction(l, d);\n",
    "    if (t.z >= l.faces) return false;\n",
    "    rsm_face_frame(l, t.z, fr, fu, a);\n",
    "    q = vec2(dot(d, fr), dot(d, fu)) / dot(d, a);\n",
    "    t.xy = min(ivec2((q * 0.5 + 0.5) * l.size), ivec2(size - 1));\n",
    "    q = vec2(rsm_texel_centre(l, t.x), rsm_texel_centre(l, t.y));\n",
    "    s = 1.0 + dot(q, q);\n",
    "    weight = point.z * r * r * l.size * l.size * s * sqrt(s);\n",
    "    return true;\n",
    "}\n",
    "\n",
    "// From numbers from to to - 1 of the list. mixed: MIXED's scale; 0 = all by flux.\n",
    "vec3 rsm_gather_list(rsm_lamp l, vec3 p, vec3 n, uint from, uint to, bool glossy, float mixed)\n",
    "{\n",
    "    vec3 sum = vec3(0.0), right, up, centre = vec3(0.0);\n",
    "    if (mixed > 0.0) centre = rsm_centre_of(l, p, true, right, up) * (l.faces == 1 ? 1.0 : 0.5);\n",
    "    for (uint i = from; i < to; i++) {\n",
    "        vec4 a = uintBitsToFloat(RSM_LIGHT(i, 0)), b = uintBitsToFloat(RSM_LIGHT(i, 1));\n",
    "        uvec4 c = RSM_LIGHT(i, 2);\n",
    "        float w = 1.0, form = rsm_texel_form(l, p, n, int(c.w >> 24), a.xyz, b.xyz, a.w, mixed > 0.0 ? 0.0 : b.w);\n",
    "        if (mixed > 0.0) {\n",
    "            ivec3 t = ivec3(c.w & 4095u, (c.w >> 12) & 4095u, c.w >> 24);\n",
    "            vec3 d = rsm_mixed_place(l, t) - centre;\n",
    "            w = (dot(d, d) + 2.7127e-5) * b.w;\n",
    "            w = w / (w + mixed);\n",
    "        }\n",
    "        vec3 light = uintBitsToFloat(c.xyz) * form;\n",
    "        if (glossy) {\n",
    "            uvec4 g = RSM_LIGHT(i, 3);\n",
    "            if (g.w != 0u) light += rsm_gloss(l, p, a.xyz, b.xyz, form, uintBitsToFloat(g.xyz), RSM_MATERIAL(g.w - 1u));\n",
    "        }\n",
    "        sum += light * w;\n",
    "    }\n",
    "    return sum;\n",
    "}\n",
    "\n",
    "// From points first, first + step, ... of the pattern, count of them, about the projection of p. limits: offset, clamp,\n",
    "// near_limit, sets that share the points. mixed, picked: MIXED; else 0. near_field: texels nearer than so many of their\n",
    "// sides are surfaces.\n",
    "vec3 rsm_gather_about(rsm_lamp l, vec3 p, vec3 n, float r_max, vec2 turn, uint first, uint step, uint count,\n",
    "                      vec4 limits, bool glossy, float mixed, float picked, float near_field)\n",
    "{\n",
    "    vec3 sum = vec3(0.0), right, up, centre = rsm_centre_of(l, p, !(r_max > 0.0), right, up);\n",
    "    float total = picked > 0.0 ? rsm_total(l) : 0.0;\n",
    "    for (uint i = 0u; i < count; i++) {\n",
    "        ivec3 t;\n",
    "        float weight;\n",
    "        if (!rsm_place_sample(l, r_max, centre, right, up, RSM_POINT_AT(first + i * step), turn, t, weight)) continue;\n",
    "        vec4 flux = uintBitsToFloat(RSM_TEXEL(t, 2));\n",
    "        float mean = rsm_mean3(flux.xyz);\n",
    "        if (!(mean > 0.0) && !glossy) continue;\n",
    "        if (total > 0.0) {\n",
    "            vec3 d = rsm_mixed_place(l, t) - centre * (l.faces == 1 ? 1.0 : 0.5);\n",
    "            weight *= mixed / ((dot(d, d) + 2.7127e-5) * picked * mean / total + mixed);\n",
    "        }\n",
    "        vec3 light = uintBitsToFloat(RSM_TEXEL(t, 0).xyz);\n",
    "        uvec4 b = RSM_TEXEL(t, 1);\n",
    "        vec3 light_normal = uintBitsToFloat(b.xyz);\n",
    "        light -= limits.x * light_normal;\n",
    "        float bound = rsm_bound_of(flux.w * weight, limits.y, limits.z);\n",
    "        float form = rsm_texel_form(l, p, n, t.z, light, light_normal, bound, near_field * near_field * flux.w);\n",
    "        vec3 e = flux.xyz * form;\n",
    "        if (glossy && b.w != 0u)\n",
    "            e += rsm_gloss(l, p, light, light_normal, form, rsm_incident(l, t.z, t.xy) * l.value,\n",
    "                           RSM_MATERIAL(b.w - 1u));\n",
    "        sum += e * (weight * limits.w);\n",
    "    }\n",
    "    return sum;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_rsm_grid_glsl[] = {
    "// rsm_grid - interpolation between nodes of a grid that were evaluated (section 4).\n",
    "// uses: rsm_screen\n",
    "// The program's: the node at a pixel, its light and what its alpha says; false where nothing is seen.\n",
    "bool rsm_node(ivec2 at, out rsm_receiver s, out vec4 node);\n",
    "\n",
    "// Grid lines of a coordinate: multiples of step, and the picture's last pixel.\n",
    "void rsm_grid_lines(int at, int step, int size, out ivec2 line, out float share)\n",
    "{\n",
    "    line = ivec2(at / step * step, min((at / step + 1) * step, size - 1));\n",
    "    share = line.y > line.x ? float(at - line.x) / float(line.y - line.x) : 0.0;\n",
    "}\n",
    "\n",
    "bool rsm_suits(rsm_receiver p, rsm_receiver s, vec4 tests, float reach2)\n",
    "{\n",
    "    vec3 d = s.position - p.position;\n",
    "    float len = length(d), plane = max(abs(dot(d, p.normal)), abs(dot(d, s.normal)));\n",
    "    if (dot(s.normal, p.normal) < tests.x || plane > tests.y * len) return false;\n",
    "    return (!(tests.z > 0.0) || len <= tests.z) && dot(d, d) <= reach2;\n",
    "}\n",
    "\n",
    "// Bilinear between nodes of the grid; false where fewer than three suit or they differ too much. A missing fourth is\n",
    "// completed to a plane. tests: least cosine, most slope, most distance or 0, contrast or below 0. reach: of a sample,\n",
    "// times its distance to the nearest light, or below 0.\n",
    "bool rsm_interpolate(ivec2 at, int step, ivec2 size, rsm_receiver p, vec4 tests, float reach, out vec3 result)\n",
    "{\n",
    "    ivec2 lx, ly;\n",
    "    vec2 f;\n",
    "    vec3 value[4];\n",
    "    float low = 3.0e38, high = 0.0, sum = 0.0;\n",
    "    int good = 0, missing = -1;\n",
    "    rsm_grid_lines(at.x, step, size.x, lx, f.x);\n",
    "    rsm_grid_lines(at.y, step, size.y, ly, f.y);\n",
    "    for (int k = 0; k < 4; k++) {\n",
    "        bool right = (k & 1) != 0, upper = (k & 2) != 0;\n",
    "        ivec2 line = ivec2(right ? lx.y : lx.x, upper ? ly.y : ly.x);\n",
    "        rsm_receiver s;\n",
    "        vec4 node;\n",
    "        bool seen = rsm_node(line, s, node);\n",
    "        value[k] = node.xyz;\n",
    "        float reach2 = reach > 0.0 ? rsm_node_distance2(node.w) * reach * reach : 3.0e38;\n",
    "        if (node.w >= 0.0 || !seen || !rsm_suits(p, s, tests, reach2)) {\n",
    "            missing = k;\n",
    "            continue;\n",
    "        }\n",
    "        float mean = rsm_mean3(node.xyz);\n",
    "        low = min(low, mean);\n",
    "        high = max(high, mean);\n",
    "        sum += mean;\n",
    "        good++;\n",
    "    }\n",
    "    result = vec3(0.0);\n",
    "    if (good < 3 || (tests.w >= 0.0 && high - low > tests.w * sum / float(good))) return false;\n",
    "    if (missing == 0) value[0] = value[1] + value[2] - value[3];\n",
    "    if (missing == 1) value[1] = value[0] + value[3] - value[2];\n",
    "    if (missing == 2) value[2] = value[3] + value[0] - value[1];\n",
    "    if (missing == 3) value[3] = value[2] + value[1] - value[0];\n",
    "    result = max(mix(mix(value[0], value[1], f.x), mix(value[2], value[3], f.x), f.y), vec3(0.0));\n",
    "    return true;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_rsm_light_glsl[] = {
    "// glbk_rsm_light, uniform block\n",
    "layout(std140) uniform glbk_rsm_light_block {\n",
    "    vec4 position;\n",
    "    vec4 right;\n",
    "    vec4 up;\n",
    "    vec4 axis;\n",
    "    vec4 value;\n",
    "} glbk_rsm_light;\n"
};

static const char *const glbk__glsl_lib_rsm_lists_glsl[] = {
    "// rsm_lists - lists of pixels that compute programs append to and read from, each with the groups of 64 that it takes.\n",
    "// A work group collects its pixels in shared memory, then takes room in the list for all of them at once.\n",
    "// uses: rsm_screen\n",
    "#ifndef RSM_GROUP\n",
    "#define RSM_GROUP 64        // invocations of the work group\n",
    "#endif\n",
    "shared uint rsm_open[RSM_GROUP], rsm_wanted[4 * RSM_GROUP];\n",
    "shared uint rsm_open_count, rsm_wanted_count, rsm_open_at, rsm_wanted_at;\n",
    "\n",
    "uint rsm_pack_pixel(ivec2 at) { return uint(at.x) | uint(at.y) << 16; }\n",
    "ivec2 rsm_unpack_pixel(uint item) { return ivec2(item & 65535u, item >> 16); }\n",
    "\n",
    "// Item of this invocation, with groups of 64 as glbk_dispatch_indirect has them; false beyond the list's end.\n",
    "bool rsm_item(uint list, out ivec2 at)\n",
    "{\n",
    "    uint i = 64u * (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) + gl_LocalInvocationIndex;\n",
    "    bool inside = i < glbk_rsm_counts[4u * list + 3u];\n",
    "    at = ivec2(0);\n",
    "    if (inside) at = rsm_unpack_pixel(glbk_rsm_items[i]);\n",
    "    return inside;\n",
    "}\n",
    "\n",
    "void rsm_begin_lists()\n",
    "{\n",
    "    if (gl_LocalInvocationIndex == 0u) rsm_open_count = rsm_wanted_count = 0u;\n",
    "    barrier();\n",
    "}\n",
    "\n",
    "void rsm_add_open(ivec2 at) { rsm_open[atomicAdd(rsm_open_count, 1u)] = rsm_pack_pixel(at); }\n",
    "\n",
    "void rsm_add_wanted(ivec2 at) { rsm_wanted[atomicAdd(rsm_wanted_count, 1u)] = rsm_pack_pixel(at); }\n",
    "\n",
    "// Place of a node among the marks.\n",
    "uint rsm_mark(ivec2 number, ivec2 last) { return uint(number.y * (last.x + 1) + number.x); }\n",
    "\n",
    "// A node that is to be evaluated where it was not yet: once, whoever asks first.\n",
    "void rsm_want(ivec2 at)\n",
    "{\n",
    "    int fine = int(glbk_rsm_frame.grid.y);\n",
    "    ivec2 number = rsm_node_number(at, fine), last = rsm_node_number(ivec2(glbk_rsm_frame.grid.zw) - 1, fine);\n",
    "    uint i = rsm_mark(number, last), bit = 1u << (i & 31u);\n",
    "    if ((glbk_rsm_marks[i >> 5] & bit) != 0u || (atomicOr(glbk_rsm_marks[i >> 5], bit) & bit) != 0u) return;\n",
    "    rsm_receiver r;\n",
    "    if (rsm_read(at, r) && texelFetch(glbk_rsm_coarse, number, 0).w >= 0.0) rsm_add_wanted(at);\n",
    "}\n",
    "\n",
    "// Room for count pixels more. Where they need another group, the list's groups become as many: rows of 1024, so that no\n",
    "// side exceeds the 65,535 that GL guarantees.\n",
    "uint rsm_room(uint list, uint count)\n",
    "{\n",
    "    uint at = atomicAdd(glbk_rsm_counts[4u * list + 3u], count);\n",
    "    uint before = (at + 63u) / 64u, groups = (at + count + 63u) / 64u;\n",
    "    if (groups > before) {\n",
    "        if (before < 1024u) atomicMax(glbk_rsm_counts[4u * list], min(groups, 1024u));\n",
    "        atomicMax(glbk_rsm_counts[4u * list + 1u], (groups + 1023u) / 1024u);\n",
    "    }\n",
    "    return at;\n",
    "}\n",
    "\n",
    "void rsm_end_lists(uint open_list, uint wanted_list)\n",
    "{\n",
    "    uint i = gl_LocalInvocationIndex;\n",
    "    barrier();\n",
    "    if (i == 0u && rsm_open_count > 0u) rsm_open_at = rsm_room(open_list, rsm_open_count);\n",
    "    if (i == 0u && rsm_wanted_count > 0u) rsm_wanted_at = rsm_room(wanted_list, rsm_wanted_count);\n",
    "    barrier();\n",
    "    if (i < rsm_open_count) glbk_rsm_left[rsm_open_at + i] = rsm_open[i];\n",
    "    for (; i < rsm_wanted_count; i += uint(RSM_GROUP)) glbk_rsm_wanted[rsm_wanted_at + i] = rsm_wanted[i];\n",
    "}\n"
};

static const char *const glbk__glsl_lib_rsm_map_glsl[] = {
    "// rsm_map - a light and its map: frames of faces, projection, light through a texel, as rsm.h has them.\n",
    "const int RSM_SUN = 1, RSM_SPOT = 2, RSM_SQUARE_SPOT = 3, RSM_POINT = 4, RSM_PATCH = 5;\n",
    "const float RSM_PI = 3.14159265;\n",
    "\n",
    "struct rsm_lamp {\n",
    "    vec3 position, right, up, axis;     // frame of face 0; light travels along axis\n",
    "    vec3 value;\n",
    "    float extent, cos_half, size;       // half a side (sun) or its tangent; of half the cone; texels a side\n",
    "    int faces, kind;\n",
    "};\n",
    "\n",
    "vec3 rsm_normalize(vec3 v)\n",
    "{\n",
    "    float d = dot(v, v);\n",
    "    return d > 0.0 ? v / sqrt(d) : vec3(0.0);\n",
    "}\n",
    "\n",
    "void rsm_face_frame(rsm_lamp l, int face, out vec3 r, out vec3 u, out vec3 a)\n",
    "{\n",
    "    r = l.right;\n",
    "    u = l.up;\n",
    "    a = l.axis;\n",
    "    if (face == 1) { r = -l.axis; a = l.right; }\n",
    "    else if (face == 2) { r = l.axis; a = -l.right; }\n",
    "    else if (face == 3) { u = -l.axis; a = l.up; }\n",
    "    else if (face == 4) { u = l.axis; a = -l.up; }\n",
    "    else if (face == 5) { r = -l.right; a = -l.axis; }\n",
    "}\n",
    "\n",
    "// In a face's frame: x and y in units of its half side, z the depth.\n",
    "vec3 rsm_to_face(rsm_lamp l, int face, vec3 p)\n",
    "{\n",
    "    vec3 r, u, a, q = p - l.position;\n",
    "    rsm_face_frame(l, face, r, u, a);\n",
    "    float z = dot(q, a);\n",
    "    return vec3(vec2(dot(q, r), dot(q, u)) / (l.kind == RSM_SUN ? l.extent : l.extent * z), z);\n",
    "}\n",
    "\n",
    "int rsm_cube_face(vec3 d)               // d in the light's frame\n",
    "{\n",
    "    vec3 a = abs(d);\n",
    "    if (a.z >= a.x && a.z >= a.y) return d.z >= 0.0 ? 0 : 5;\n",
    "    if (a.x >= a.y) return d.x >= 0.0 ? 1 : 2;\n",
    "    return d.y >= 0.0 ? 3 : 4;\n",
    "}\n",
    "\n",
    "int rsm_face_of_direction(rsm_lamp l, vec3 d)\n",
    "{\n",
    "    return l.faces == 1 ? 0 : rsm_cube_face(vec3(dot(d, l.right), dot(d, l.up), dot(d, l.axis)));\n",
    "}\n",
    "\n",
    "float rsm_texel_centre(rsm_lamp l, int i) { return (float(i) + 0.5) * 2.0 / l.size - 1.0; }\n",
    "\n",
    "vec3 rsm_to_light(rsm_lamp l, vec3 p) { return l.kind == RSM_SUN ? -l.axis : rsm_normalize(l.position - p); }\n",
    "\n",
    "// Light of value 1 through the part q +- h of a face, in its plane at distance 1: cos^3 integrated by Gauss points.\n",
    "float rsm_solid_angle(rsm_lamp l, vec3 r, vec3 u, vec3 a, vec2 q, float h)\n",
    "{\n",
    "    float sum = 0.0;\n",
    "    int n = h < 0.05 ? 2 : 4;\n",
    "    for (int j = 0; j < n; j++)\n",
    "        for (int i = 0; i < n; i++) {\n",
    "            ivec2 k = ivec2(i, j);\n",
    "            vec2 sign = vec2(greaterThanEqual(k * 2, ivec2(n))) * 2.0 - 1.0;\n",
    "            bvec2 outer = equal(k % 3, ivec2(0));\n",
    "            vec2 node = n == 2 ? vec2(0.577350269) : mix(vec2(0.339981044), vec2(0.861136312), vec2(outer));\n",
    "            vec2 weight = n == 2 ? vec2(0.5) : mix(vec2(0.326072577), vec2(0.173927423), vec2(outer));\n",
    "            vec2 s = q + h * sign * node;\n",
    "            float c = 1.0 / (1.0 + dot(s, s)), f = c * sqrt(c);\n",
    "            if (l.kind == RSM_PATCH) f *= max(dot(l.axis, a + r * s.x + u * s.y) * sqrt(c), 0.0);\n",
    "            sum += f * weight.x * weight.y;\n",
    "        }\n",
    "    return sum * 4.0 * h * h;\n",
    "}\n",
    "\n",
    "bool rsm_in_cone(rsm_lamp l, vec3 r, vec3 u, vec3 a, vec2 q)\n",
    "{\n",
    "    vec3 d = a + r * q.x + u * q.y;\n",
    "    return dot(l.axis, d) >= l.cos_half * length(d);\n",
    "}\n",
    "\n",
    "// Light of value 1 through texel (i, j) of a face, as much of it as lies in the cone.\n",
    "float rsm_incident(rsm_lamp l, int face, ivec2 t)\n",
    "{\n",
    "    float h = l.extent / l.size;\n",
    "    if (l.kind == RSM_SUN) return 4.0 * h * h;\n",
    "    vec3 r, u, a;\n",
    "    rsm_face_frame(l, face, r, u, a);\n",
    "    vec2 q = vec2(rsm_texel_centre(l, t.x), rsm_texel_centre(l, t.y)) * l.extent;\n",
    "    float flux = rsm_solid_angle(l, r, u, a, q, h);\n",
    "    if (l.kind != RSM_SPOT) return flux;\n",
    "    int corners = 0, covered = 0;\n",
    "    for (int k = 0; k < 4; k++)\n",
    "        corners += int(rsm_in_cone(l, r, u, a, q + h * vec2((k & 1) != 0 ? 1.0 : -1.0, (k & 2) != 0 ? 1.0 : -1.0)));\n",
    "    if (corners == 4) return flux;\n",
    "    if (corners == 0 && !rsm_in_cone(l, r, u, a, q)) return 0.0;\n",
    "    for (int k = 0; k < 64; k++)\n",
    "        covered += int(rsm_in_cone(l, r, u, a, q + h * (vec2(float(k & 7), float(k >> 3)) - 3.5) * 0.25));\n",
    "    return flux * float(covered) * (1.0 / 64.0);\n",
    "}\n",
    "\n",
    "// Surface that a texel stands for: the cross section of its beam over the cosine, grazing ones bounded.\n",
    "float rsm_area(rsm_lamp l, int face, vec3 p, vec3 n)\n",
    "{\n",
    "    vec3 r, u, a, to = rsm_to_light(l, p);\n",
    "    rsm_face_frame(l, face, r, u, a);\n",
    "    float side = 2.0 * l.extent / l.size * (l.kind == RSM_SUN ? 1.0 : dot(p - l.position, a));\n",
    "    return side * side * (l.kind == RSM_SUN ? 1.0 : abs(dot(a, to))) / max(abs(dot(n, to)), 0.05);\n",
    "}\n",
    "\n",
    "float rsm_mean3(vec3 v) { return (v.x + v.y + v.z) * (1.0 / 3.0); }\n"
};

static const char *const glbk__glsl_lib_rsm_pick_glsl[] = {
    "// rsm_pick - texels of a map in proportion to their flux, by running sums.\n",
    "// uses: rsm_access rsm_bound\n",
    "uint rsm_hash32(uint x)\n",
    "{\n",
    "    uint state = x * 747796405u + 2891336453u;\n",
    "    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;\n",
    "    return (word >> 22) ^ word;\n",
    "}\n",
    "\n",
    "uint rsm_hash_combine(uint a, uint b) { return rsm_hash32(a + 0x9e3779b9u * rsm_hash32(b)); }\n",
    "float rsm_to_unit(uint bits) { return float(bits >> 8) * (1.0 / 16777216.0); }\n",
    "float rsm_random(uint seed, uint stream, uint i)\n",
    "{\n",
    "    return rsm_to_unit(rsm_hash_combine(rsm_hash_combine(seed, stream), i));\n",
    "}\n",
    "\n",
    "float rsm_total(rsm_lamp l)\n",
    "{\n",
    "    float total = 0.0;\n",
    "    for (int f = 0; f < l.faces; f++) total += RSM_ROWS_SUM(int(l.size) - 1, f);\n",
    "    return total;\n",
    "}\n",
    "\n",
    "// Texel and weight of sample i of n: a lattice, rows at even steps, places in them by the golden ratio, shifted by the\n",
    "// seed. false: no light.\n",
    "bool rsm_pick_texel(rsm_lamp l, uint i, uint n, uint seed, out ivec3 t, out float weight)\n",
    "{\n",
    "    float total = rsm_total(l), u = fract(rsm_to_unit(i * 2654435769u) + rsm_random(seed, 5u, 0u));\n",
    "    float x = min((float(i) + rsm_random(seed, 6u, 0u)) / float(n), 0.99999994) * total;\n",
    "    int size = int(l.size), low = 0, high = size - 1;\n",
    "    t = ivec3(0);\n",
    "    weight = 0.0;\n",
    "    if (!(total > 0.0)) return false;\n",
    "    for (int f = 0; f + 1 < l.faces; f++) {\n",
    "        float sum = RSM_ROWS_SUM(size - 1, f);\n",
    "        if (t.z != f || x < sum) continue;\n",
    "        x -= sum;\n",
    "        t.z = f + 1;\n",
    "    }\n",
    "    while (low < high) {                    // the first row whose sum exceeds x\n",
    "        int middle = (low + high) / 2;\n",
    "        if (RSM_ROWS_SUM(middle, t.z) > x) high = middle;\n",
    "        else low = middle + 1;\n",
    "    }\n",
    "    t.y = low;\n",
    "    x = min(u, 0.99999994) * RSM_ROW_SUM(ivec3(size - 1, t.yz));\n",
    "    low = 0;\n",
    "    high = size - 1;\n",
    "    while (low < high) {                    // and the first texel\n",
    "        int middle = (low + high) / 2;\n",
    "        if (RSM_ROW_SUM(ivec3(middle, t.yz)) > x) high = middle;\n",
    "        else low = middle + 1;\n",
    "    }\n",
    "    t.x = low;\n",
    "    float flux = rsm_mean3(uintBitsToFloat(RSM_TEXEL(t, 2).xyz));\n",
    "    if (!(flux > 0.0)) return false;\n",
    "    weight = total / (float(n) * flux);\n",
    "    return true;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_rsm_screen_glsl[] = {
    "// rsm_screen - receivers of the G-buffer, nodes of grids between which light is interpolated, neighbours of filters.\n",
    "// uses: rsm_access\n",
    "#define RSM_NONE 0.0            // what alpha says of a pixel: nothing seen there\n",
    "#define RSM_OPEN 1.0\n",
    "#define RSM_INTERPOLATED 2.0\n",
    "#define RSM_EVALUATED 3.0       // and in the step before this one:\n",
    "#define RSM_FRESH 4.0\n",
    "\n",
    "// Nodes of a grid say in alpha how far away their nearest light is: -d^2 2^60 in the step that evaluates them, -d^2 /\n",
    "// 2^60 afterwards, so that both can be told apart and no bit is lost.\n",
    "#define RSM_NODE_SCALE 1152921504606846976.0\n",
    "bool rsm_node_fresh(float alpha) { return alpha < -1.0; }\n",
    "float rsm_node_distance2(float alpha)\n",
    "{\n",
    "    return rsm_node_fresh(alpha) ? -alpha / RSM_NODE_SCALE : -alpha * RSM_NODE_SCALE;\n",
    "}\n",
    "float rsm_node_alpha(float distance2)\n",
    "{\n",
    "    return -clamp(distance2, 4.0 / RSM_NODE_SCALE, 0.25 * RSM_NODE_SCALE) * RSM_NODE_SCALE;\n",
    "}\n",
    "float rsm_node_aged(float alpha) { return rsm_node_fresh(alpha) ? alpha / RSM_NODE_SCALE / RSM_NODE_SCALE : alpha; }\n",
    "\n",
    "struct rsm_receiver { vec3 position, normal; float occlusion; };\n",
    "\n",
    "bool rsm_read(ivec2 at, out rsm_receiver r)\n",
    "{\n",
    "    uvec4 place = RSM_SEEN(at, 0);\n",
    "    r.position = uintBitsToFloat(place.xyz);\n",
    "    r.occlusion = clamp(uintBitsToFloat(place.w), 0.0, 1.0);\n",
    "    r.normal = uintBitsToFloat(RSM_SEEN(at, 1).xyz);\n",
    "    return dot(r.normal, r.normal) > 0.25;\n",
    "}\n",
    "\n",
    "// Which set of an interleaved picture a pixel takes.\n",
    "uint rsm_set(ivec2 at)\n",
    "{\n",
    "    uint k = glbk_rsm_frame.counts.y;\n",
    "    return uint(at.x) % k + k * (uint(at.y) % k);\n",
    "}\n",
    "\n",
    "// Is `at` a node of the grid? number: which; those of coarser grids have one in finer ones, too.\n",
    "ivec2 rsm_node_number(ivec2 at, int step) { return (at + step - 1) / step; }\n",
    "\n",
    "bool rsm_is_node(ivec2 at, int step, ivec2 size, out ivec2 number)\n",
    "{\n",
    "    number = rsm_node_number(at, step);\n",
    "    return (at.x % step == 0 || at.x == size.x - 1) && (at.y % step == 0 || at.y == size.y - 1);\n",
    "}\n",
    "\n",
    "// Weight of a neighbour or of history for p: 0 across edges of normals and off the plane, falling smoothly to them.\n",
    "float rsm_alike(vec3 p, vec3 n, vec3 q, vec3 m, float cosine, float slope)\n",
    "{\n",
    "    vec3 d = q - p;\n",
    "    float off = dot(n, d), a = clamp((dot(n, m) - cosine) / (1.0 - cosine), 0.0, 1.0);\n",
    "    return a * max(1.0 - off * off / (slope * slope * dot(d, d) + 1e-12), 0.0);\n",
    "}\n"
};

static const char *const glbk__glsl_lib_rsm_smooth_glsl[] = {
    "// rsm_smooth - one pass of the a-trous filter: 1 2 1 by 1 2 1, `step` pixels apart, stopped by edges of normals and\n",
    "// planes. A pixel with few neighbours like it is no brighter than its brightest neighbour.\n",
    "// uses: rsm_screen\n",
    "// The program's: the neighbour (i, j) steps away from pixel `at`; false where nothing is seen, or beyond the picture.\n",
    "bool rsm_neighbour(ivec2 at, ivec2 off, out rsm_receiver s, out vec3 light);\n",
    "\n",
    "// sum: light of the pixel, which alpha goes with.\n",
    "vec4 rsm_smooth(ivec2 at, rsm_receiver r, vec4 sum)\n",
    "{\n",
    "    vec3 light = sum.xyz * 4.0, most = vec3(0.0);\n",
    "    float total = 4.0;\n",
    "    for (int j = -1; j <= 1; j++)\n",
    "        for (int i = -1; i <= 1; i++) {\n",
    "            rsm_receiver s;\n",
    "            vec3 other;\n",
    "            if ((i == 0 && j == 0) || !rsm_neighbour(at, ivec2(i, j), s, other)) continue;\n",
    "            float weight = rsm_alike(r.position, r.normal, s.position, s.normal, glbk_rsm_frame.tests.x,\n",
    "                                     glbk_rsm_frame.tests.y) * (i != 0 && j != 0 ? 1.0 : 2.0);\n",
    "            light += weight * other;\n",
    "            total += weight;\n",
    "            most = max(most, other);\n",
    "        }\n",
    "    light /= total;\n",
    "    if (total < 8.0) light = mix(light, min(light, most), vec3(greaterThan(most, vec3(0.0))));\n",
    "    return vec4(light, sum.w);\n",
    "}\n"
};

static const char *const glbk__glsl_lib_sfield_access_glsl[] = {
    "// sfield_access - what sfield_field asks of a program, from the textures that glbk_sfield_bind binds.\n",
    "// uses: table sfield_bindings\n",
    "#define SFIELD_TEXEL(i) texelFetch(glbk_sfield_table, glbk_table_at(i), 0)\n",
    "#define SFIELD_MOVING(i) texelFetch(glbk_sfield_moving, glbk_table_at(i), 0)\n",
    "#ifndef SFIELD_BANDS\n",
    "#define SFIELD_BANDS 4\n",
    "#endif\n",
    "#ifndef SFIELD_GLOSS\n",
    "#define SFIELD_GLOSS 0\n",
    "#endif\n"
};

static const char *const glbk__glsl_lib_sfield_bindings_glsl[] = {
    "// sfield_bindings - from the lists GLBK_SFIELD_* of gl_backend.h.\n",
    "uniform usampler2DArray glbk_sfield_table;\n",
    "uniform usampler2D glbk_sfield_place;\n",
    "uniform usampler2D glbk_sfield_normal;\n",
    "uniform usampler2DArray glbk_sfield_self;\n",
    "uniform usampler2D glbk_sfield_seen;\n",
    "uniform usampler2D glbk_sfield_cube;\n",
    "uniform usampler2DArray glbk_sfield_basis;\n",
    "uniform usampler2DArray glbk_sfield_moving;\n",
    "#if __VERSION__ >= 430\n",
    "layout(rgba32f, binding = 0) writeonly uniform image2D glbk_sfield_light_image;\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(rgba32f, binding = 1) writeonly uniform image2D glbk_sfield_gloss_image;\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(rgba32ui, binding = 2) writeonly uniform uimage2D glbk_sfield_cube_image;\n",
    "#endif\n",
    "#if __VERSION__ >= 430\n",
    "layout(rgba32ui, binding = 3) writeonly uniform uimage2D glbk_sfield_coefs_image;\n",
    "#endif\n"
};

static const char *const glbk__glsl_lib_sfield_field_glsl[] = {
    "// sfield_field - shadow fields at a point, and the algebra of their coefficients. C twins: shadowfield.h.\n",
    "//\n",
    "// Functions of direction are float[SFIELD_COEFS] of real spherical harmonics, number l^2 + l + m, Y1 = 0.4886 (y, z,\n",
    "// x). Fields and tripling coefficients lie in one table, rotations in that of what moves or, without SFIELD_MOVING, the\n",
    "// same (docs/gpu-layouts.md); they are named by their first texel.\n",
    "#ifndef SFIELD_TEXEL\n",
    "#error \"SFIELD_TEXEL(i): texel i of the table as uvec4\"\n",
    "#endif\n",
    "#ifndef SFIELD_BANDS\n",
    "#error \"SFIELD_BANDS: 1 to 8\"\n",
    "#endif\n",
    "#ifndef SFIELD_MOVING\n",
    "#define SFIELD_MOVING(i) SFIELD_TEXEL(i)                // texel i of sky, entities and rotations\n",
    "#endif\n",
    "#ifndef SFIELD_ROTATION\n",
    "#define SFIELD_ROTATION(i) SFIELD_MOVING(i)             // texel i of a rotation\n",
    "#endif\n",
    "#define SFIELD_COEFS (SFIELD_BANDS * SFIELD_BANDS)\n",
    "#define SFIELD_CELLS ((SFIELD_COEFS + 15) / 16)         // texels of a sample and channel\n",
    "#define SFIELD_NONE 0xffffffffu\n",
    "#define SFIELD_PI 3.14159265\n",
    "#define SFIELD_Y00 0.282094792\n",
    "\n",
    "// Eight samples round a point: the inner shell's are first, + 1, + side, + side + 1; the outer's 6 side^2 later.\n",
    "struct sfield_place {\n",
    "    uint first, shell;\n",
    "    vec4 corner;            // weights of the four on a shell\n",
    "    vec2 weight;            // of the inner and of the outer shell; falls beyond the last one\n",
    "};\n",
    "\n",
    "// 4/pi atan u for |u| <= 1, 6e-6: equal angles between the nodes of the grid of positions.\n",
    "float sfield_warp(float u)\n",
    "{\n",
    "    float z = u * u;\n",
    "    return u + u * (1.0 - z) * (0.273219633 + z * (-0.150161507 + z * (0.0946681494 + z * (-0.0487783181 +\n",
    "                                                                                           z * 0.0127531015))));\n",
    "}\n",
    "\n",
    "// What weights are linear in. Bits of how: 1 a source, 2 uniform shells.\n",
    "float sfield_measure(float d2, uint how)\n",
    "{\n",
    "    float inverse = 1.0 / d2, u = min(inverse, 1.0);\n",
    "    if ((how & 2u) != 0u) return -sqrt(d2);\n",
    "    return (how & 1u) != 0u || d2 < 1.0 ? inverse : u / (1.0 + sqrt(1.0 - u));\n",
    "}\n",
    "\n",
    "// p: in the field's space, about its center, in r.\n",
    "sfield_place sfield_locate(uint field, vec3 p)\n",
    "{\n",
    "    uvec4 head = SFIELD_TEXEL(field);                   // how, frames, shells, side\n",
    "    vec3 a = abs(p);\n",
    "    float m = max(max(a.x, a.y), a.z), d2 = dot(p, p), inverse = 1.0 / max(m, 1e-20);\n",
    "    bool on_x = m == a.x, on_y = m == a.y && !on_x;\n",
    "    uint face = on_x ? (p.x > 0.0 ? 0u : 1u) : on_y ? (p.y > 0.0 ? 2u : 3u) : p.z > 0.0 ? 4u : 5u;\n",
    "    float s = on_x ? (p.x > 0.0 ? -p.z : p.z) : on_y ? p.x : p.z > 0.0 ? p.x : -p.x;\n",
    "    float t = on_y ? (p.y > 0.0 ? p.z : -p.z) : -p.y;\n",
    "    vec2 grid = (vec2(sfield_warp(s * inverse), sfield_warp(t * inverse)) + 1.0) * (0.5 * float(head.w - 1u));\n",
    "    uvec2 at = uvec2(min(grid, vec2(float(head.w) - 1.5)));\n",
    "    vec2 f = grid - vec2(at);\n",
    "    uint low = 0u, high = head.z - 1u;                  // the last shell but one at most\n",
    "    while (high - low > 1u) {\n",
    "        uint middle = (low + high) >> 1;\n",
    "        if (uintBitsToFloat(SFIELD_TEXEL(field + 3u + middle).x) <= d2) low = middle;\n",
    "        else high = middle;\n",
    "    }\n",
    "    vec2 inner = uintBitsToFloat(SFIELD_TEXEL(field + 3u + low).xy);\n",
    "    vec2 outer = uintBitsToFloat(SFIELD_TEXEL(field + 4u + low).xy);\n",
    "    float last = uintBitsToFloat(SFIELD_TEXEL(field + 2u + head.z).x), q = max(d2, 1e-12);\n",
    "    float w = clamp((sfield_measure(q, head.x) - outer.y) / (inner.y - outer.y), 0.0, 1.0);\n",
    "    sfield_place place;\n",
    "    place.first = ((low * 6u + face) * head.w + at.y) * head.w + at.x;\n",
    "    place.shell = low;\n",
    "    place.corner = vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);\n",
    "    place.weight = vec2(w, (1.0 - w) * min(last / q, 1.0));\n",
    "    return place;\n",
    "}\n",
    "\n",
    "vec4 sfield_bytes(uint word)\n",
    "{\n",
    "    return vec4(float(word & 255u), float((word >> 8) & 255u), float((word >> 16) & 255u), float(word >> 24));\n",
    "}\n",
    "\n",
    "// v += weight x the four samples from `first` on, which belong to `group`.\n",
    "void sfield_mix(uint field, uint first, uint group, uint channel, vec4 corner, float weight,\n",
    "                inout float v[SFIELD_COEFS])\n",
    "{\n",
    "    uvec4 parts = SFIELD_TEXEL(field + 1u);             // channels, scales, samples\n",
    "    uint side = SFIELD_TEXEL(field).w, cells = uint(SFIELD_CELLS), step = parts.x * cells;\n",
    "    uint from = field + parts.z + first * step + channel * cells;\n",
    "    uint scale = field + parts.y + (group * parts.x + channel) * 8u * cells;\n",
    "    for (int cell = 0; cell < SFIELD_CELLS; cell++, from++) {\n",
    "        uvec4 a = SFIELD_TEXEL(from), b = SFIELD_TEXEL(from + step);\n",
    "        uvec4 c = SFIELD_TEXEL(from + side * step), d = SFIELD_TEXEL(from + (side + 1u) * step);\n",
    "        for (int word = 0; word < 4; word++) {\n",
    "            uint at = scale + uint(4 * cell + word);\n",
    "            vec4 q = corner.x * sfield_bytes(a[word]) + corner.y * sfield_bytes(b[word]) +\n",
    "                     corner.z * sfield_bytes(c[word]) + corner.w * sfield_bytes(d[word]);\n",
    "            q = weight * (q * uintBitsToFloat(SFIELD_TEXEL(at)) + uintBitsToFloat(SFIELD_TEXEL(at + 4u * cells)));\n",
    "            for (int i = 0; i < 4; i++)\n",
    "                if (16 * cell + 4 * word + i < SFIELD_COEFS) v[16 * cell + 4 * word + i] += q[i];\n",
    "        }\n",
    "    }\n",
    "}\n",
    "\n",
    "// One channel of a field, times weight: what is hidden, or radiance at a time in seconds. Here as below, loops over\n",
    "// large bodies end at numbers that compilers do not know, which would unroll them and take seconds.\n",
    "void sfield_fetch(uint field, sfield_place at, uint channel, float time, float weight, out float v[SFIELD_COEFS])\n",
    "{\n",
    "    uvec4 head = SFIELD_TEXEL(field);\n",
    "    uint before = 0u, after = 0u, shell = 6u * head.w * head.w;\n",
    "    float t = 0.0;\n",
    "    for (int k = 0; k < SFIELD_COEFS; k++) v[k] = 0.0;\n",
    "    if (head.y > 1u) {\n",
    "        float n = float(head.y);\n",
    "        bool loop = (head.x & 4u) != 0u;\n",
    "        t = time * uintBitsToFloat(SFIELD_TEXEL(field + 2u).x);\n",
    "        if (loop) t = clamp(t, -1e7, 1e7) - n * floor(clamp(t, -1e7, 1e7) / n);\n",
    "        t = max(t, 0.0);\n",
    "        t = t < n ? t : loop ? 0.0 : n;\n",
    "        before = min(uint(t), head.y - 1u);\n",
    "        after = before + 1u < head.y ? before + 1u : loop ? 0u : before;\n",
    "        t = t - float(before) < 1.0 ? t - float(before) : 0.0;\n",
    "    }\n",
    "    for (uint i = 0u; i < (t > 0.0 ? 4u : 2u); i++) {           /* inner, outer shell; before, after */\n",
    "        uint frame = (i < 2u ? before : after) * head.z, outer = i & 1u;\n",
    "        float w = weight * (i < 2u ? 1.0 - t : t) * (outer == 0u ? at.weight.x : at.weight.y);\n",
    "        if (w != 0.0)\n",
    "            sfield_mix(field, (frame + outer) * shell + at.first, frame + at.shell + outer, channel, at.corner, w, v);\n",
    "    }\n",
    "}\n",
    "\n",
    "// ---- algebra ----\n",
    "\n",
    "// A function of direction turned by a rotation of the table, or back. Rows of 4 ceil((2l+1)/4) numbers, from band 1.\n",
    "void sfield_rotate(uint rotation, bool back, inout float v[SFIELD_COEFS])\n",
    "{\n",
    "    uint row = rotation;\n",
    "    for (int l = 1; l < SFIELD_BANDS; l++) {\n",
    "        float sum[2 * SFIELD_BANDS];\n",
    "        int n = 2 * l + 1, first = l * l;\n",
    "        for (int x = 0; x < n; x++) sum[x] = 0.0;\n",
    "        for (int y = 0; y < n; y++)\n",
    "            for (int x = 0; x < n; x += 4, row++) {\n",
    "                vec4 m = uintBitsToFloat(SFIELD_ROTATION(row));\n",
    "                for (int i = 0; i < 4; i++)\n",
    "                    if (x + i < n) {\n",
    "                        if (back) sum[x + i] += m[i] * v[first + y];\n",
    "                        else sum[y] += m[i] * v[first + x + i];\n",
    "                    }\n",
    "            }\n",
    "        for (int x = 0; x < n; x++) v[first + x] = sum[x];\n",
    "    }\n",
    "}\n",
    "\n",
    "// r = a b, projected: terms.y pairs of tripling coefficients from texel terms.x on, i | j << 8 | k << 16 and c each, in\n",
    "// fours: software drivers end an invocation's loops after 65535 rounds in all. With SFIELD_UNROLLED the program has\n",
    "// this function with its numbers in it (glbk_sfield_write_product).\n",
    "#ifndef SFIELD_UNROLLED\n",
    "void sfield_product(uvec2 terms, float a[SFIELD_COEFS], float b[SFIELD_COEFS], out float r[SFIELD_COEFS])\n",
    "{\n",
    "    r[0] = a[0] * b[0];\n",
    "    for (int k = 1; k < SFIELD_COEFS; k++) {\n",
    "        r[0] += a[k] * b[k];\n",
    "        r[k] = SFIELD_Y00 * (a[0] * b[k] + a[k] * b[0]);\n",
    "    }\n",
    "    r[0] *= SFIELD_Y00;\n",
    "    for (uint e = 0u; e < terms.y; e += 4u)\n",
    "        for (uint of = 0u; of < 4u; of++) {\n",
    "            uvec4 two = SFIELD_TEXEL(terms.x + e + of);\n",
    "            for (int h = 0; h < 2; h++) {\n",
    "                uint which = h == 0 ? two.x : two.z, i = which & 255u, j = (which >> 8) & 255u;\n",
    "                r[which >> 16] += uintBitsToFloat(h == 0 ? two.y : two.w) * (a[i] * b[j] + a[j] * b[i]);\n",
    "            }\n",
    "        }\n",
    "}\n",
    "#endif\n",
    "\n",
    "// The basis at a unit direction.\n",
    "void sfield_basis(vec3 d, out float y[SFIELD_COEFS])\n",
    "{\n",
    "    float c = 1.0, s = 0.0, diagonal = SFIELD_Y00;\n",
    "    for (int m = 0; m < SFIELD_BANDS; m++) {\n",
    "        float older = 0.0, now = m > 0 ? 1.41421356 * diagonal : diagonal, fm = float(m);\n",
    "        for (int l = m; l < SFIELD_BANDS; l++) {\n",
    "            float fl = float(l), back = l > 0 ? sqrt((fl * fl - fm * fm) / (4.0 * fl * fl - 1.0)) : 0.0;\n",
    "            float a = sqrt((4.0 * (fl + 1.0) * (fl + 1.0) - 1.0) / ((fl + 1.0) * (fl + 1.0) - fm * fm));\n",
    "            float next = a * (d.z * now - back * older);\n",
    "            y[l * l + l - m] = now * s;\n",
    "            y[l * l + l + m] = now * c;\n",
    "            older = now;\n",
    "            now = next;\n",
    "        }\n",
    "        diagonal *= sqrt((2.0 * fm + 3.0) / (2.0 * fm + 2.0));\n",
    "        float turned = c * d.x - s * d.y;\n",
    "        s = c * d.y + s * d.x;\n",
    "        c = turned;\n",
    "    }\n",
    "}\n",
    "\n",
    "// max(0, cosine) about a unit normal: T of a point that nothing of its own hides.\n",
    "void sfield_cosine(vec3 n, out float t[SFIELD_COEFS])\n",
    "{\n",
    "    const float a[8] = float[8](3.14159265, 2.09439510, 0.785398163, 0.0, -0.130899694, 0.0, 0.0490873852, 0.0);\n",
    "    sfield_basis(n, t);\n",
    "    for (int l = 0; l < SFIELD_BANDS; l++)\n",
    "        for (int k = l * l; k < (l + 1) * (l + 1); k++) t[k] *= a[l];\n",
    "}\n",
    "\n",
    "// Phong's (n + 2) / 2 pi cos^n about the mirrored view, n in 1..1000.\n",
    "void sfield_lobe(vec3 mirrored, float n, out float t[SFIELD_COEFS])\n",
    "{\n",
    "    float before = (n + 2.0) / (n + 1.0), now = 1.0;\n",
    "    sfield_basis(mirrored, t);\n",
    "    t[0] *= before;\n",
    "    for (int l = 1; l < SFIELD_BANDS; l++) {\n",
    "        for (int k = l * l; k < (l + 1) * (l + 1); k++) t[k] *= now;\n",
    "        float next = before * (n - float(l) + 1.0) / (n + float(l) + 2.0);\n",
    "        before = now;\n",
    "        now = next;\n",
    "    }\n",
    "}\n",
    "\n",
    "float sfield_dot(float a[SFIELD_COEFS], float b[SFIELD_COEFS])\n",
    "{\n",
    "    float sum = 0.0;\n",
    "    for (int k = 0; k < SFIELD_COEFS; k++) sum += a[k] * b[k];\n",
    "    return sum;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_sfield_frame_glsl[] = {
    "// glbk_sfield_frame, uniform block\n",
    "layout(std140) uniform glbk_sfield_frame_block {\n",
    "    vec4 eye;\n",
    "} glbk_sfield_frame;\n"
};

static const char *const glbk__glsl_lib_sfield_gbuffer_glsl[] = {
    "// sfield_gbuffer - the G-buffer of glbk_sfield: floats as their bits (docs/gpu-layouts.md).\n",
    "// uses: sfield_shade\n",
    "struct sfield_point { vec3 position, normal; uint entity; float exponent; bool recorded; };     // exponent 0: no lobe\n",
    "\n",
    "// false: nothing is seen there.\n",
    "bool sfield_read_point(ivec2 at, out sfield_point p)\n",
    "{\n",
    "    uvec4 place = texelFetch(glbk_sfield_place, at, 0), normal = texelFetch(glbk_sfield_normal, at, 0);\n",
    "    p.position = uintBitsToFloat(place.xyz);\n",
    "    p.normal = uintBitsToFloat(normal.xyz);\n",
    "    p.entity = place.w;\n",
    "    p.exponent = abs(uintBitsToFloat(normal.w));\n",
    "    p.recorded = (normal.w >> 31) != 0u;\n",
    "    return dot(p.normal, p.normal) > 0.5;\n",
    "}\n",
    "\n",
    "// Own visibility x cosine, in the world: from the G-buffer, two numbers a word in 1/32767 of 1.5; else the cosine.\n",
    "void sfield_start(ivec2 at, sfield_point p, out float t[SFIELD_COEFS])\n",
    "{\n",
    "    if (!p.recorded) {\n",
    "        sfield_cosine(p.normal, t);\n",
    "        return;\n",
    "    }\n",
    "    for (int layer = 0; 8 * layer < SFIELD_COEFS; layer++) {\n",
    "        uvec4 words = texelFetch(glbk_sfield_self, ivec3(at, layer), 0);\n",
    "        for (int k = 0; k < 8; k++) {\n",
    "            int bits = int((k & 1) != 0 ? words[k >> 1] : words[k >> 1] << 16) >> 16;\n",
    "            if (8 * layer + k < SFIELD_COEFS) t[8 * layer + k] = float(bits) * (1.5 / 32767.0);\n",
    "        }\n",
    "    }\n",
    "    if (p.entity != SFIELD_NONE) {\n",
    "        uint rotation = SFIELD_MOVING(sfield_at(p.entity) + 5u).z;\n",
    "        if (rotation != SFIELD_NONE) sfield_rotate(rotation, false, t);\n",
    "    }\n",
    "}\n",
    "\n",
    "// Light, gloss and what is open, as the textures of the renderer hold them.\n",
    "sfield_sums sfield_shade_point(ivec2 at, sfield_point p)\n",
    "{\n",
    "    float t[SFIELD_COEFS], g[SFIELD_COEFS];\n",
    "    sfield_start(at, p, t);\n",
    "    for (int k = 0; k < SFIELD_COEFS; k++) g[k] = 0.0;\n",
    "#if SFIELD_GLOSS\n",
    "    vec3 view = glbk_sfield_frame.eye.xyz - p.position;\n",
    "    float r[SFIELD_COEFS];\n",
    "    if (p.exponent > 0.0 && dot(view, view) > 0.0) {\n",
    "        sfield_lobe(reflect(-normalize(view), p.normal), clamp(p.exponent, 1.0, 1000.0), r);\n",
    "        sfield_product(glbk_sfield_scene.parts.xy, t, r, g);\n",
    "    }\n",
    "#endif\n",
    "    sfield_sums sums = sfield_shade(p.position, p.normal, p.entity, t, g);\n",
    "    return sfield_sums(sums.light * (1.0 / SFIELD_PI), sums.gloss, sums.open / (SFIELD_PI * SFIELD_Y00));\n",
    "}\n"
};

static const char *const glbk__glsl_lib_sfield_list_glsl[] = {
    "// sfield_list - the entities that a work group needs, found by it together: what hides anything of its points and all\n",
    "// that shines, nearest first, with their texels and rotations in shared memory. Compute shaders, before sfield_shade.\n",
    "// uses: sfield_access\n",
    "#ifndef SFIELD_GROUP\n",
    "#define SFIELD_GROUP 64u            // invocations of a work group, a power of two\n",
    "#endif\n",
    "#define SFIELD_ENTITY 7u\n",
    "#define SFIELD_LISTED 128u          // entities; where more are needed, all are gone through, in the table\n",
    "#define SFIELD_STAGED 768u          // texels of rotations: 28 of 4 bands, 3 of 8; others are read from the table\n",
    "#define SFIELD_TURNED 0x80000000u   // a rotation that is in shared memory\n",
    "\n",
    "shared uvec4 sfield_texels[SFIELD_LISTED * SFIELD_ENTITY + SFIELD_STAGED];\n",
    "shared uint sfield_numbers[SFIELD_LISTED], sfield_turns[SFIELD_LISTED], sfield_listed, sfield_turned;\n",
    "shared vec2 sfield_spans[SFIELD_LISTED];\n",
    "\n",
    "// A name: the number in the table, and the place in the list or, of more than it holds, 255.\n",
    "bool sfield_all() { return sfield_listed > SFIELD_LISTED; }\n",
    "uint sfield_name(uint i) { return sfield_all() ? i << 8 | 255u : sfield_numbers[i] << 8 | i; }\n",
    "\n",
    "uvec4 sfield_record(uint name, uint k)\n",
    "{\n",
    "    if ((name & 255u) == 255u) return SFIELD_MOVING(glbk_sfield_scene.table.x + (name >> 8) * SFIELD_ENTITY + k);\n",
    "    return sfield_texels[(name & 255u) * SFIELD_ENTITY + k];\n",
    "}\n",
    "\n",
    "uvec4 sfield_rotation_texel(uint i)\n",
    "{\n",
    "    if (i < SFIELD_TURNED) return SFIELD_MOVING(i);\n",
    "    return sfield_texels[SFIELD_LISTED * SFIELD_ENTITY + (i & ~SFIELD_TURNED)];\n",
    "}\n",
    "\n",
    "#define SFIELD_COUNT (sfield_all() ? glbk_sfield_scene.table.y : sfield_listed)\n",
    "#define SFIELD_NAME(i) sfield_name(i)\n",
    "#define SFIELD_NUMBER(name) (name >> 8)\n",
    "#define SFIELD_RECORD(name, k) sfield_record(name, k)\n",
    "#define SFIELD_NEAR(i) (sfield_all() ? 0.0 : sfield_spans[i].x)\n",
    "#define SFIELD_FAR(i) (sfield_all() ? 3e38 : sfield_spans[i].y)\n",
    "#define SFIELD_ROTATION(i) sfield_rotation_texel(i)\n",
    "\n",
    "void sfield_wait()\n",
    "{\n",
    "    memoryBarrierShared();\n",
    "    barrier();\n",
    "}\n",
    "\n",
    "// Boxes round the points and round their normals.\n",
    "struct sfield_box { vec3 low, high, normal_low, normal_high; };\n",
    "\n",
    "sfield_box sfield_bound(vec3 position, vec3 normal, bool seen)\n",
    "{\n",
    "    uint me = gl_LocalInvocationIndex;\n",
    "    bool counts = seen && all(lessThan(abs(position), vec3(1e18)));\n",
    "    vec3 least[4] = vec3[4](position, -position, normal, -normal);\n",
    "    for (uint k = 0u; k < 4u; k++)\n",
    "        sfield_texels[k * SFIELD_GROUP + me] = floatBitsToUint(vec4(counts ? least[k] : vec3(3e38), 0.0));\n",
    "    for (uint rest = SFIELD_GROUP / 2u; rest > 0u; rest >>= 1u) {\n",
    "        sfield_wait();\n",
    "        for (uint k = 0u; k < 4u && me < rest; k++) {\n",
    "            uint at = k * SFIELD_GROUP + me;\n",
    "            vec4 a = uintBitsToFloat(sfield_texels[at]), b = uintBitsToFloat(sfield_texels[at + rest]);\n",
    "            sfield_texels[at] = floatBitsToUint(min(a, b));\n",
    "        }\n",
    "    }\n",
    "    sfield_wait();\n",
    "    for (uint k = 0u; k < 4u; k++) least[k] = uintBitsToFloat(sfield_texels[k * SFIELD_GROUP].xyz);\n",
    "    sfield_wait();                  // before others write there\n",
    "    return sfield_box(least[0], -least[1], least[2], -least[3]);\n",
    "}\n",
    "\n",
    "// Least and greatest square of the distance of a point from the box; a little more room than rounding takes.\n",
    "vec2 sfield_span(sfield_box b, vec3 p)\n",
    "{\n",
    "    vec3 near = max(max(b.low - p, p - b.high), 0.0), far = max(abs(b.low - p), abs(b.high - p));\n",
    "    return vec2(0.99999 * dot(near, near), 1.00001 * dot(far, far));\n",
    "}\n",
    "\n",
    "// Is any of a sphere above the horizon of any point? Rather yes.\n",
    "bool sfield_above(sfield_box b, vec3 p, float radius)\n",
    "{\n",
    "    vec3 from = p - b.high, to = p - b.low;\n",
    "    vec3 most = max(max(from * b.normal_low, from * b.normal_high), max(to * b.normal_low, to * b.normal_high));\n",
    "    vec3 room = 1e-6 * max(abs(from), abs(to));\n",
    "    return most.x + most.y + most.z + room.x + room.y + room.z > -radius;\n",
    "}\n",
    "\n",
    "// Called once by all invocations; seen: false = no point of its own.\n",
    "void sfield_list(vec3 position, vec3 normal, bool seen)\n",
    "{\n",
    "    const uint rotation_texels[8] = uint[8](1u, 3u, 13u, 27u, 54u, 87u, 139u, 199u);\n",
    "    const uint turn = rotation_texels[SFIELD_BANDS - 1], turns = min(SFIELD_STAGED / turn, SFIELD_LISTED);\n",
    "    uint me = gl_LocalInvocationIndex;\n",
    "    sfield_listed = sfield_turned = 0u;         // before the first wait\n",
    "    sfield_box box = sfield_bound(position, normal, seen);\n",
    "    if (box.low.x > box.high.x) return;\n",
    "    for (uint e = me; e < glbk_sfield_scene.table.y; e += SFIELD_GROUP) {\n",
    "        uint at = glbk_sfield_scene.table.x + e * SFIELD_ENTITY;\n",
    "        vec4 occluder = uintBitsToFloat(SFIELD_MOVING(at)), source = uintBitsToFloat(SFIELD_MOVING(at + 1u));\n",
    "        vec2 span = sfield_span(box, occluder.xyz), light = source.w > 0.0 ? sfield_span(box, source.xyz) : vec2(0.0);\n",
    "        bool hides = span.x < occluder.w && sfield_above(box, occluder.xyz, uintBitsToFloat(SFIELD_MOVING(at + 3u).w));\n",
    "        if (!hides && !(source.w > 0.0)) continue;\n",
    "        span = vec2(source.w > 0.0 ? light.x : span.x, hides ? max(span.y, light.y) : light.y);\n",
    "        uint slot = atomicAdd(sfield_listed, 1u);\n",
    "        if (slot < SFIELD_LISTED) sfield_texels[slot] = uvec4(e, floatBitsToUint(span), 0u);\n",
    "    }\n",
    "    sfield_wait();\n",
    "    uint listed = sfield_listed;\n",
    "    if (listed > SFIELD_LISTED) return;\n",
    "    for (uint i = me; i < listed; i += SFIELD_GROUP) {          // the bits of spans sort as they are not negative\n",
    "        uvec4 mine = sfield_texels[i];\n",
    "        uint rank = 0u;\n",
    "        for (uint k = 0u; k < listed; k++) {\n",
    "            uvec4 other = sfield_texels[k];\n",
    "            if (other.y < mine.y || (other.y == mine.y && other.x < mine.x)) rank++;\n",
    "        }\n",
    "        sfield_numbers[rank] = mine.x;\n",
    "        sfield_spans[rank] = uintBitsToFloat(mine.yz);\n",
    "    }\n",
    "    sfield_wait();\n",
    "    for (uint i = me; i < listed * SFIELD_ENTITY; i += SFIELD_GROUP)\n",
    "        sfield_texels[i] = SFIELD_MOVING(glbk_sfield_scene.table.x + sfield_numbers[i / SFIELD_ENTITY] * SFIELD_ENTITY +\n",
    "                                         i % SFIELD_ENTITY);\n",
    "    sfield_wait();\n",
    "    for (uint i = me; i < listed; i += SFIELD_GROUP) {\n",
    "        uint at = i * SFIELD_ENTITY + 5u, rotation = sfield_texels[at].z;\n",
    "        if (rotation == 0xffffffffu) continue;\n",
    "        uint slot = atomicAdd(sfield_turned, 1u);\n",
    "        if (slot >= turns) continue;\n",
    "        sfield_turns[slot] = rotation;\n",
    "        sfield_texels[at].z = SFIELD_TURNED | slot * turn;\n",
    "    }\n",
    "    sfield_wait();\n",
    "    for (uint i = me; i < min(sfield_turned, turns) * turn; i += SFIELD_GROUP)\n",
    "        sfield_texels[SFIELD_LISTED * SFIELD_ENTITY + i] = SFIELD_MOVING(sfield_turns[i / turn] + i % turn);\n",
    "    sfield_wait();\n",
    "}\n"
};

static const char *const glbk__glsl_lib_sfield_object_glsl[] = {
    "// glbk_sfield_object, uniform block\n",
    "layout(std140) uniform glbk_sfield_object_block {\n",
    "    mat4 world;\n",
    "    mat4 clip;\n",
    "    uvec4 kinds;\n",
    "    vec4 gloss;\n",
    "} glbk_sfield_object;\n"
};

static const char *const glbk__glsl_lib_sfield_scene_glsl[] = {
    "// glbk_sfield_scene, uniform block\n",
    "layout(std140) uniform glbk_sfield_scene_block {\n",
    "    uvec4 table;\n",
    "    uvec4 parts;\n",
    "} glbk_sfield_scene;\n"
};

static const char *const glbk__glsl_lib_sfield_shade_glsl[] = {
    "// sfield_shade - light at a point in the scene that glbk_sfield_bind bound, near to far (paper, figure 5).\n",
    "// uses: sfield_access sfield_field\n",
    "\n",
    "// Entities of the table, SFIELD_ENTITY texels each: occluder's centre and the square of its reach (0 hides nothing),\n",
    "// source's centre and radius (0 does not shine), three rows of the turn into field space (w: inscribed radius, radius\n",
    "// of the occluder, time), (occluder, source, rotation, 0), tint. World units.\n",
    "#ifndef SFIELD_ENTITY\n",
    "#define SFIELD_ENTITY 7u\n",
    "#endif\n",
    "#define SFIELD_BATCH 8              // entities found at a time\n",
    "#define SFIELD_BLOCKERS 4           // inscribed spheres that are remembered\n",
    "\n",
    "struct sfield_sums { vec3 light, gloss; float open; };      // without 1 / pi; T(0) after all\n",
    "\n",
    "uint sfield_at(uint entity) { return glbk_sfield_scene.table.x + entity * SFIELD_ENTITY; }\n",
    "\n",
    "// The entities that are gone through: all of the table, or what sfield_list found. Number i has a name, which rises\n",
    "// with its number in the table and leads to its texels; NEAR and FAR bound its distances from the points, squared.\n",
    "#ifndef SFIELD_NAME\n",
    "#define SFIELD_COUNT glbk_sfield_scene.table.y\n",
    "#define SFIELD_NAME(i) i\n",
    "#define SFIELD_NUMBER(name) name\n",
    "#define SFIELD_RECORD(name, k) SFIELD_MOVING(sfield_at(name) + k)\n",
    "#define SFIELD_NEAR(i) 0.0\n",
    "#define SFIELD_FAR(i) 3e38\n",
    "#endif\n",
    "#define SFIELD_HIDES 0x80000000u\n",
    "\n",
    "vec3 sfield_turn(uint entity, vec3 v)\n",
    "{\n",
    "    return vec3(dot(uintBitsToFloat(SFIELD_RECORD(entity, 2u).xyz), v),\n",
    "                dot(uintBitsToFloat(SFIELD_RECORD(entity, 3u).xyz), v),\n",
    "                dot(uintBitsToFloat(SFIELD_RECORD(entity, 4u).xyz), v));\n",
    "}\n",
    "\n",
    "// The next SFIELD_BATCH in distance after (d2, id): a light has its entity's name as id, an occluder SFIELD_HIDES more;\n",
    "// of the same distance lights come first. An entity does not hide itself from its own light: it follows then; it\n",
    "// neither hides nor lights its own points. SFIELD_NONE ends them. Entities before `first` have been gone through.\n",
    "void sfield_find(vec3 position, uint own, float d2, uint id, inout uint first, out float key[SFIELD_BATCH],\n",
    "                 out uint name[SFIELD_BATCH])\n",
    "{\n",
    "    uint count = SFIELD_COUNT;\n",
    "    while (first < count && SFIELD_FAR(first) < d2) first++;\n",
    "    for (int i = 0; i < SFIELD_BATCH; i++) {\n",
    "        key[i] = 3e38;\n",
    "        name[i] = SFIELD_NONE;\n",
    "    }\n",
    "    for (uint at = first; at < count && SFIELD_NEAR(at) <= key[SFIELD_BATCH - 1]; at++) {\n",
    "        uint e = SFIELD_NAME(at);\n",
    "        if (SFIELD_NUMBER(e) == own) continue;\n",
    "        vec4 occluder = uintBitsToFloat(SFIELD_RECORD(e, 0u)), source = uintBitsToFloat(SFIELD_RECORD(e, 1u));\n",
    "        vec3 v = occluder.xyz - position, w = source.xyz - position;\n",
    "        float far = dot(v, v), light = source.w > 0.0 ? dot(w, w) : 0.0;\n",
    "        for (int what = 0; what < 2; what++) {\n",
    "            float k = what == 0 ? light : max(far, light);\n",
    "            uint n = what == 0 ? e : e | SFIELD_HIDES;\n",
    "            bool there = what == 0 ? source.w > 0.0 : far < occluder.w;\n",
    "            if (!there || !(k > d2 || (k == d2 && (id == SFIELD_NONE || n > id)))) continue;\n",
    "            for (int i = 0; i < SFIELD_BATCH; i++)\n",
    "                if (k < key[i] || (k == key[i] && n < name[i])) {\n",
    "                    float a = key[i];\n",
    "                    uint b = name[i];\n",
    "                    key[i] = k;\n",
    "                    name[i] = n;\n",
    "                    k = a;\n",
    "                    n = b;\n",
    "                }\n",
    "        }\n",
    "    }\n",
    "}\n",
    "\n",
    "// Inscribed spheres of what was met, as cones: axis, cosine of the half angle.\n",
    "struct sfield_blockers { vec4 cone[SFIELD_BLOCKERS]; int count; };\n",
    "\n",
    "// Is a bounding sphere, in direction v at distance d with that sine, inside one of them?\n",
    "bool sfield_hidden(sfield_blockers b, vec3 v, float sin_a)\n",
    "{\n",
    "    float cos_a = sqrt(max(1.0 - sin_a * sin_a, 0.0));\n",
    "    bool hidden = false;\n",
    "    for (int i = 0; i < SFIELD_BLOCKERS; i++) {\n",
    "        float cos_b = b.cone[i].w, sin_b = sqrt(max(1.0 - cos_b * cos_b, 0.0));\n",
    "        hidden = hidden || (i < b.count && sin_a < sin_b && dot(v, b.cone[i].xyz) >= cos_a * cos_b + sin_a * sin_b);\n",
    "    }\n",
    "    return hidden;\n",
    "}\n",
    "\n",
    "vec3 sfield_local(uint entity, vec4 sphere, vec3 position)\n",
    "{\n",
    "    return sfield_turn(entity, position - sphere.xyz) / sphere.w;\n",
    "}\n",
    "\n",
    "// Alpha of an occluder, in the world; false: nothing of it counts. It fades over the last quarter of its reach, and\n",
    "// hides nothing below the horizon or behind an inscribed sphere.\n",
    "bool sfield_occlusion(uint entity, vec3 position, vec3 normal, inout sfield_blockers met, out float o[SFIELD_COEFS])\n",
    "{\n",
    "    uvec4 what = SFIELD_RECORD(entity, 5u);\n",
    "    vec4 place = uintBitsToFloat(SFIELD_RECORD(entity, 0u));\n",
    "    float radius = uintBitsToFloat(SFIELD_RECORD(entity, 3u).w);\n",
    "    float inscribed = uintBitsToFloat(SFIELD_RECORD(entity, 2u).w);\n",
    "    vec3 v = place.xyz - position;\n",
    "    float d = length(v), factor = clamp(4.0 * (1.0 - d * inversesqrt(place.w)), 0.0, 1.0);\n",
    "    if (!(factor > 0.0) || !(dot(v, normal) > -radius)) return false;\n",
    "    if (radius < d && sfield_hidden(met, v / d, radius / d)) return false;\n",
    "    if (inscribed > 0.0 && inscribed < d && factor >= 1.0 && met.count < SFIELD_BLOCKERS) {\n",
    "        for (int i = 0; i < SFIELD_BLOCKERS; i++)\n",
    "            if (i == met.count) met.cone[i] = vec4(v / d, sqrt(1.0 - inscribed * inscribed / (d * d)));\n",
    "        met.count++;\n",
    "    }\n",
    "    for (int k = 0; k < SFIELD_COEFS; k++) o[k] = 0.0;\n",
    "    sfield_fetch(what.x, sfield_locate(what.x, sfield_local(entity, vec4(place.xyz, radius), position)), 0u, 0.0,\n",
    "                 factor, o);\n",
    "    if (what.z != SFIELD_NONE) sfield_rotate(what.z, false, o);\n",
    "    return true;\n",
    "}\n",
    "\n",
    "// A sum into channel c; a source of one channel has three equal ones.\n",
    "vec3 sfield_channel(vec3 rgb, uint c, float sum)\n",
    "{\n",
    "    return c == 0u ? vec3(sum) : c == 1u ? vec3(rgb.x, sum, sum) : vec3(rgb.xy, sum);\n",
    "}\n",
    "\n",
    "// T . radiance of a light, and the same of g; both are turned into its space.\n",
    "void sfield_light(uint entity, vec3 position, float t[SFIELD_COEFS], float g[SFIELD_COEFS], inout sfield_sums sums)\n",
    "{\n",
    "    uvec4 what = SFIELD_RECORD(entity, 5u);\n",
    "    vec4 sphere = uintBitsToFloat(SFIELD_RECORD(entity, 1u));\n",
    "    sfield_place place = sfield_locate(what.y, sfield_local(entity, sphere, position));\n",
    "    float time = uintBitsToFloat(SFIELD_RECORD(entity, 4u).w), v[SFIELD_COEFS];\n",
    "    vec3 light = vec3(0.0), gloss = vec3(0.0), tint = uintBitsToFloat(SFIELD_RECORD(entity, 6u).xyz);\n",
    "    if (what.z != SFIELD_NONE) {\n",
    "        sfield_rotate(what.z, true, t);\n",
    "#if SFIELD_GLOSS\n",
    "        sfield_rotate(what.z, true, g);\n",
    "#endif\n",
    "    }\n",
    "    for (uint c = 0u; c < SFIELD_TEXEL(what.y + 1u).x; c++) {    // 3 channels\n",
    "        sfield_fetch(what.y, place, c, time, 1.0, v);\n",
    "        light = sfield_channel(light, c, sfield_dot(v, t));\n",
    "#if SFIELD_GLOSS\n",
    "        gloss = sfield_channel(gloss, c, sfield_dot(v, g));\n",
    "#endif\n",
    "    }\n",
    "    sums.light += light * tint;\n",
    "    sums.gloss += gloss * tint;\n",
    "}\n",
    "\n",
    "vec3 sfield_sky(float t[SFIELD_COEFS])\n",
    "{\n",
    "    uint at = glbk_sfield_scene.parts.z;\n",
    "    vec3 rgb = vec3(0.0);\n",
    "    for (int k = 0; k < SFIELD_COEFS; k++) rgb += t[k] * uintBitsToFloat(SFIELD_MOVING(at + uint(k)).xyz);\n",
    "    return rgb;\n",
    "}\n",
    "\n",
    "void sfield_apply(float o[SFIELD_COEFS], inout float t[SFIELD_COEFS])\n",
    "{\n",
    "    float r[SFIELD_COEFS];\n",
    "    sfield_product(glbk_sfield_scene.parts.xy, t, o, r);\n",
    "    for (int k = 0; k < SFIELD_COEFS; k++) t[k] -= r[k];\n",
    "}\n",
    "\n",
    "// own: the entity that the point lies on, which neither hides it (its start does) nor lights it, or SFIELD_NONE.\n",
    "// t: own visibility x cosine, in the world (sfield_cosine, or what was recorded, turned); g: the same x Phong's lobe,\n",
    "// used where SFIELD_GLOSS is 1.\n",
    "sfield_sums sfield_shade(vec3 position, vec3 normal, uint own, float t[SFIELD_COEFS], float g[SFIELD_COEFS])\n",
    "{\n",
    "    sfield_sums sums = sfield_sums(vec3(0.0), vec3(0.0), 0.0);\n",
    "    uint count = glbk_sfield_scene.table.y, left = glbk_sfield_scene.table.z, id = SFIELD_NONE, first = 0u;\n",
    "    uint name[SFIELD_BATCH];\n",
    "    if (own < count && uintBitsToFloat(SFIELD_MOVING(sfield_at(own) + 1u).w) > 0.0) left--;\n",
    "    bool sky = glbk_sfield_scene.table.w != 0u, more = left > 0u || sky;\n",
    "    float d2 = 0.0, o[SFIELD_COEFS], key[SFIELD_BATCH];\n",
    "    sfield_blockers met;\n",
    "    met.count = 0;\n",
    "    for (int i = 0; i < SFIELD_BLOCKERS; i++) met.cone[i] = vec4(0.0);\n",
    "    while (more) {\n",
    "        sfield_find(position, own, d2, id, first, key, name);\n",
    "        for (uint i = 0u; i < min(uint(SFIELD_BATCH), 2u * count + 1u) && more; i++) {\n",
    "            for (int k = 0; k < SFIELD_BATCH; k++)\n",
    "                if (uint(k) == i) {\n",
    "                    d2 = key[k];\n",
    "                    id = name[k];\n",
    "                }\n",
    "            if (id == SFIELD_NONE) {\n",
    "                more = false;\n",
    "            } else if (id < SFIELD_HIDES) {\n",
    "                sfield_light(id, position, t, g, sums);\n",
    "                left--;\n",
    "                more = left > 0u || sky;\n",
    "            } else if (sfield_occlusion(id & ~SFIELD_HIDES, position, normal, met, o)) {\n",
    "                sfield_apply(o, t);\n",
    "#if SFIELD_GLOSS\n",
    "                sfield_apply(o, g);\n",
    "#endif\n",
    "            }\n",
    "        }\n",
    "    }\n",
    "    if (sky) {\n",
    "        sums.light += sfield_sky(t);\n",
    "#if SFIELD_GLOSS\n",
    "        sums.gloss += sfield_sky(g);\n",
    "#endif\n",
    "    }\n",
    "    sums.open = t[0];\n",
    "    return sums;\n",
    "}\n"
};

static const char *const glbk__glsl_lib_sfield_views_glsl[] = {
    "// glbk_sfield_views, uniform block\n",
    "layout(std140) uniform glbk_sfield_views_block {\n",
    "    vec4 sphere;\n",
    "    uvec4 how;\n",
    "    uvec4 size;\n",
    "    vec4 eyes[256];\n",
    "    uvec4 places[256];\n",
    "} glbk_sfield_views;\n"
};

static const char *const glbk__glsl_lib_table_glsl[] = {
    "// table - where texel i of a table stands: 1024 wide, 1024 high, then layers (glbk_table_create).\n",
    "ivec3 glbk_table_at(uint i)\n",
    "{\n",
    "    return ivec3(uvec3(i & 1023u, i >> 10 & 1023u, i >> 20));\n",
    "}\n"
};

static const char *const glbk__glsl_prog_copy_frag[] = {
    "// Copies a GLBK_FORMAT_COLOR texture, texel by texel, to the same pixels of a target: of the same kind or, with\n",
    "// TO_COLOR, of colours.\n",
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

static const char *const glbk__glsl_prog_csm_compress_comp[] = {
    "// csm_compress.frag as a compute shader: four uvec4 a pixel, the open segment and the records.\n",
    "// uses: csm_compress\n",
    "layout(local_size_x = 8, local_size_y = 8) in;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_GlobalInvocationID.xy);\n",
    "    uint size = glbk_csm_peel.tiles.x, i = 4u * (uint(at.y) * size + uint(at.x));\n",
    "    if (uint(at.x) >= size || uint(at.y) >= size) return;\n",
    "    uvec4 s = glbk_csm_records[i];\n",
    "    csm_open o = csm_open(s.x & 255u, (s.x >> 8) & 255u, (s.x >> 16) != 0u, s.y);\n",
    "    csm_ended ended = csm_compress(at, o);\n",
    "    glbk_csm_records[i] = uvec4(o.lo | (o.hi << 8) | (o.fresh ? 1u << 16 : 0u), o.next, ended.count, 0u);\n",
    "    glbk_csm_records[i + 1u] = ended.records[0];\n",
    "    glbk_csm_records[i + 2u] = ended.records[1];\n",
    "    glbk_csm_records[i + 3u] = ended.records[2];\n",
    "}\n"
};

static const char *const glbk__glsl_prog_csm_compress_frag[] = {
    "// One pixel of the maps a fragment; its open segment goes on in the first target.\n",
    "// uses: csm_compress\n",
    "// with: screen.vert\n",
    "layout(location = 0) out uvec4 open_now;\n",
    "layout(location = 1) out uvec4 records0;\n",
    "layout(location = 2) out uvec4 records1;\n",
    "layout(location = 3) out uvec4 records2;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n",
    "    uvec4 s = texelFetch(glbk_csm_opened, at, 0);\n",
    "    csm_open o = csm_open(s.x & 255u, (s.x >> 8) & 255u, (s.x >> 16) != 0u, s.y);\n",
    "    csm_ended ended = csm_compress(at, o);\n",
    "    open_now = uvec4(o.lo | (o.hi << 8) | (o.fresh ? 1u << 16 : 0u), o.next, ended.count, 0u);\n",
    "    records0 = ended.records[0];\n",
    "    records1 = ended.records[1];\n",
    "    records2 = ended.records[2];\n",
    "}\n"
};

static const char *const glbk__glsl_prog_csm_gbuffer_frag[] = {
    "// One object into the G-buffer, with diffuse, specular and normal maps.\n",
    "// uses: csm_gbuffer\n",
    "// with: csm_gbuffer.vert\n",
    "in vec3 csm_place, csm_facing;\n",
    "in vec2 csm_uv;\n",
    "in vec4 csm_along;\n",
    "layout(location = 0) out uvec4 csm_out_place;\n",
    "layout(location = 1) out uvec4 csm_out_normal;\n",
    "layout(location = 2) out uvec4 csm_out_color;\n",
    "layout(location = 3) out uvec4 csm_out_gloss;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    uvec4 kinds = glbk_csm_object.kinds;        // BRDF, instance or COHSM_NO_SELF, 1 + plane, maps as bits\n",
    "    vec3 view = glbk_csm_object.eye.xyz - csm_place;\n",
    "    vec3 flat_normal = cohsm_normalize(cross(dFdx(csm_place), dFdy(csm_place)));\n",
    "    if (dot(flat_normal, flat_normal) == 0.0) flat_normal = cohsm_normalize(csm_facing);    // so far out, all one place\n",
    "    if (dot(flat_normal, view) < 0.0) flat_normal = -flat_normal;\n",
    "    vec3 n = dot(csm_facing, csm_facing) > 0.0 ? cohsm_normalize(csm_facing) : flat_normal;\n",
    "    if (dot(n, flat_normal) < 0.0) n = -n;\n",
    "    vec3 t = csm_along.xyz - n * dot(csm_along.xyz, n);\n",
    "    bool has_tangent = dot(t, t) > 0.0;\n",
    "    if (has_tangent) t = cohsm_normalize(t);\n",
    "    if ((kinds.w & 4u) != 0u) {                 // fetched where all of a quad do, for the level\n",
    "        vec3 bump = texture(glbk_csm_normal_map, csm_uv).xyz * 2.0 - 1.0;\n",
    "        bump.y *= csm_along.w < 0.0 ? -1.0 : 1.0;\n",
    "        if (has_tangent) n = cohsm_normalize(t * bump.x + cross(n, t) * bump.y + n * bump.z);\n",
    "    }\n",
    "    vec3 diffuse = glbk_csm_object.diffuse.xyz;\n",
    "    vec4 gloss = glbk_csm_object.gloss;\n",
    "    if ((kinds.w & 1u) != 0u) diffuse *= texture(glbk_csm_color_map, csm_uv).xyz;\n",
    "    if ((kinds.w & 2u) != 0u) {\n",
    "        vec4 map = texture(glbk_csm_gloss_map, csm_uv);\n",
    "        if (kinds.x == COHSM_BRDF_PHONG) gloss.xyz *= map.xyz;\n",
    "        if (kinds.x == COHSM_BRDF_METAL_ROUGH) gloss.xy *= map.zy;      // glTF: roughness in g, metallic in b\n",
    "    }\n",
    "    csm_out_place = uvec4(floatBitsToUint(csm_place), kinds.y);\n",
    "    csm_out_normal = uvec4(floatBitsToUint(n), kinds.x | (kinds.z << 8));\n",
    "    csm_out_color = uvec4(floatBitsToUint(diffuse), csm_pack_unit(flat_normal));\n",
    "    csm_out_gloss = kinds.x == COHSM_BRDF_LAFORTUNE\n",
    "                        ? uvec4(glbk_csm_object.lobes.xy, has_tangent ? csm_pack_unit(t) : 0xffffffffu, 0u)\n",
    "                        : floatBitsToUint(gloss);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_csm_gbuffer_vert[] = {
    "// Attributes 0 position, 1 normal, 2 texture coordinates, 3 tangent (w: handedness).\n",
    "// uses: csm_bindings\n",
    "layout(location = 0) in vec3 position;\n",
    "layout(location = 1) in vec3 normal;\n",
    "layout(location = 2) in vec2 uv;\n",
    "layout(location = 3) in vec4 tangent;\n",
    "out vec3 csm_place, csm_facing;\n",
    "out vec2 csm_uv;\n",
    "out vec4 csm_along;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    mat3 m = mat3(glbk_csm_object.world);\n",
    "    csm_place = (glbk_csm_object.world * vec4(position, 1.0)).xyz;\n",
    "    csm_facing = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * normal;\n",
    "    csm_along = vec4(m * tangent.xyz, tangent.w);\n",
    "    csm_uv = uv;\n",
    "    gl_Position = glbk_csm_object.clip * vec4(csm_place, 1.0);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_csm_peel_frag[] = {
    "// Depth peeling: the nearest surface behind the layer before. Depths as bits of floats; above 1: none.\n",
    "// uses: csm_bindings\n",
    "// with: csm_peel.vert\n",
    "// sets: CSM_FIRST=1 | CSM_FIRST=0\n",
    "#ifndef CSM_FIRST\n",
    "#define CSM_FIRST 1\n",
    "#endif\n",
    "#if !defined(GL_ES) && __VERSION__ < 420      // else the output alone\n",
    "invariant\n",
    "#endif\n",
    "in float csm_depth;\n",
    "layout(location = 0) out uint result;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    float depth = clamp(csm_depth, 0.0, 1.0);\n",
    "#if CSM_FIRST == 0\n",
    "    if (depth <= uintBitsToFloat(texelFetch(glbk_csm_layer1, ivec2(gl_FragCoord.xy), 0).x)) discard;\n",
    "#endif\n",
    "    result = floatBitsToUint(depth);\n",
    "    gl_FragDepth = depth;\n",
    "}\n"
};

static const char *const glbk__glsl_prog_csm_peel_vert[] = {
    "// A view of a csm builder: attribute 0 is the position. Depth is a varying, so that nothing is cut in front or behind;\n",
    "// two programs peel with it and compare it exactly, hence invariant.\n",
    "// uses: csm_bindings\n",
    "layout(location = 0) in vec3 position;\n",
    "invariant gl_Position;\n",
    "invariant out float csm_depth;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    vec4 p = glbk_csm_peel.view * vec4(position, 1.0);\n",
    "    float w = glbk_csm_peel.values.y > 0.0 ? p.w : 1.0;\n",
    "    csm_depth = glbk_csm_peel.values.y > 0.0 ? w * glbk_csm_peel.values.y : p.z;\n",
    "    gl_Position = vec4(p.xy * glbk_csm_peel.values.x - w, 0.0, w);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_csm_query_comp[] = {
    "// csm_query.frag as a compute shader over storage buffers.\n",
    "// uses: csm_visible\n",
    "// sets: CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 CSM_INSTANCES=1 | CSM_ASK=1 CSM_FILTER=2 | CSM_ASK=2 CSM_FILTER=1\n",
    "layout(local_size_x = 64) in;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    uint i = gl_GlobalInvocationID.y * 65536u + gl_GlobalInvocationID.x;\n",
    "    if (i >= glbk_csm_frame.range.x) return;\n",
    "    uvec4 point = glbk_csm_asked[2u * i], light = glbk_csm_asked[2u * i + 1u], range = glbk_csm_frame.range;\n",
    "    cohsm_query q = cohsm_query(CSM_ASK, CSM_FILTER, glbk_csm_frame.query.x, range.w, light.w);\n",
    "    glbk_csm_answers[i] = csm_visible(point.w, q, uintBitsToFloat(point.xyz), uintBitsToFloat(light.xyz));\n",
    "}\n"
};

static const char *const glbk__glsl_prog_csm_query_frag[] = {
    "// Answers a table of questions, two texels each: point, instance that it lies on; light, number for roulette.\n",
    "// uses: csm_visible\n",
    "// with: screen.vert\n",
    "// sets: CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 CSM_INSTANCES=1 | CSM_ASK=1 CSM_FILTER=2 | CSM_ASK=2 CSM_FILTER=1\n",
    "layout(location = 0) out uvec4 result;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    uint i = uint(gl_FragCoord.y) * 1024u + uint(gl_FragCoord.x);\n",
    "    result = uvec4(0u);\n",
    "    if (i >= glbk_csm_frame.range.x) return;    // the last row is drawn whole\n",
    "    uvec4 point = texelFetch(glbk_csm_questions, glbk_table_at(2u * i), 0);\n",
    "    uvec4 light = texelFetch(glbk_csm_questions, glbk_table_at(2u * i + 1u), 0);\n",
    "    uvec4 range = glbk_csm_frame.range;\n",
    "    cohsm_query q = cohsm_query(CSM_ASK, CSM_FILTER, glbk_csm_frame.query.x, range.w, light.w);\n",
    "    result = uvec4(floatBitsToUint(csm_visible(point.w, q, uintBitsToFloat(point.xyz), uintBitsToFloat(light.xyz))),\n",
    "                   0u, 0u, 0u);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_csm_resolve_frag[] = {
    "// The mean of the frames summed up so far, as colours.\n",
    "// uses: csm_bindings\n",
    "// with: screen.vert\n",
    "layout(location = 0) out vec4 result;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy) - ivec2(glbk_csm_frame.range.xy);\n",
    "    vec4 sum = glbk_unpack(texelFetch(glbk_csm_sum, at, 0));\n",
    "    result = vec4(glbk_csm_frame.query.z > 0.0 ? sum.rgb * glbk_csm_frame.query.z : vec3(0.0), 1.0);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_csm_shade_comp[] = {
    "// csm_shade.frag as a compute shader: the sums are an image, changed in place.\n",
    "// uses: csm_gbuffer csm_shade\n",
    "// sets: CSM_SHAPE=1 CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 CSM_INSTANCES=1 | CSM_SHAPE=6 CSM_ASK=2 CSM_FILTER=2 COHSM_LOBES=8 CSM_PATTERNS=1\n",
    "layout(local_size_x = 8, local_size_y = 8) in;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_GlobalInvocationID.xy);\n",
    "    uint i = uint(at.y) * glbk_csm_frame.tables.z + uint(at.x);\n",
    "    csm_point p;\n",
    "    if (uint(at.x) >= glbk_csm_frame.tables.z || uint(at.y) >= glbk_csm_frame.tables.w) return;\n",
    "    vec4 sum = glbk_csm_frame.query.w > 0.0 ? imageLoad(glbk_csm_total, at) : vec4(0.0);\n",
    "    if (csm_read_point(at, p)) sum += csm_shade(p, i);\n",
    "    imageStore(glbk_csm_total, at, sum);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_csm_shade_frag[] = {
    "// Adds samples of one light to the running sum.\n",
    "// uses: csm_gbuffer csm_shade\n",
    "// with: screen.vert\n",
    "// sets: CSM_SHAPE=1 CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 CSM_INSTANCES=1 | CSM_SHAPE=6 CSM_ASK=2 CSM_FILTER=2 COHSM_LOBES=8 CSM_PATTERNS=1\n",
    "layout(location = 0) out glbk_color result;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n",
    "    vec4 sum = glbk_csm_frame.query.w > 0.0 ? glbk_unpack(texelFetch(glbk_csm_sum, at, 0)) : vec4(0.0);\n",
    "    csm_point p;\n",
    "    if (csm_read_point(at, p)) sum += csm_shade(p, uint(at.y) * glbk_csm_frame.tables.z + uint(at.x));\n",
    "    result = glbk_pack(sum);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_envsh_cast_frag[] = {
    "// Depth of a caster.\n",
    "// uses: envsh_cast\n",
    "// with: envsh_cast.vert\n",
    "// sets: ENVSH_RGBA=0 | ENVSH_RGBA=1\n",
    "in float envsh_depth;\n",
    "#if ENVSH_RGBA\n",
    "layout(location = 0) out uvec4 envsh_bits;\n",
    "#endif\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ENVSH_STORE(envsh_depth)\n",
    "}\n"
};

static const char *const glbk__glsl_prog_envsh_cast_vert[] = {
    "// A caster: attribute 0 is the position.\n",
    "// uses: envsh_cast\n",
    "// sets: ENVSH_RGBA=0 | ENVSH_RGBA=1\n",
    "layout(location = 0) in vec3 position;\n",
    "out float envsh_depth;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ENVSH_CAST((glbk_envsh_object.world * vec4(position, 1.0)).xyz)\n",
    "}\n"
};

static const char *const glbk__glsl_prog_envsh_cells_frag[] = {
    "// Least and greatest depth of cells: of 8 x 8 texels of the atlas, or of 2 x 2 cells of the level below, which is then\n",
    "// the texture's base level.\n",
    "// uses: envsh_access\n",
    "// with: screen.vert\n",
    "// sets: ENVSH_RGBA=0 | ENVSH_RGBA=1\n",
    "layout(location = 0) out uvec4 result;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n",
    "    uvec4 job = glbk_envsh_object.lights;       // level, layer, channels\n",
    "    vec2 bounds = vec2(1.0, 0.0);\n",
    "    if (job.x == 0u) {\n",
    "        int cells = int(glbk_envsh_scene.tiles.w), last = int(glbk_envsh_scene.tiles.x) - 1;\n",
    "        ivec2 tile = at / cells, from = (at - tile * cells) * 8;\n",
    "        uint place = uint(tile.x) | (uint(tile.y) << 11) | ((job.y / job.z) << 22);\n",
    "        for (int i = 0; i < 64; i++) {\n",
    "            float z = envsh_stored(job.y % job.z, place, min(from + ivec2(i & 7, i >> 3), ivec2(last)));\n",
    "            bounds = vec2(min(bounds.x, z), max(bounds.y, z));\n",
    "        }\n",
    "    } else {\n",
    "        for (int i = 0; i < 4; i++) {\n",
    "            ivec3 below = ivec3(2 * at + ivec2(i & 1, i >> 1), int(job.y));\n",
    "            vec2 b = uintBitsToFloat(texelFetch(glbk_envsh_cells, below, 0).xy);\n",
    "            bounds = vec2(min(bounds.x, b.x), max(bounds.y, b.y));\n",
    "        }\n",
    "    }\n",
    "    result = uvec4(floatBitsToUint(bounds), 0u, 0u);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_envsh_gbuffer_frag[] = {
    "// One object into the G-buffer: place (w: 1), shading normal, the surface's own normal, albedo.\n",
    "// uses: envsh_bindings\n",
    "// with: envsh_gbuffer.vert\n",
    "in vec3 envsh_at, envsh_facing;\n",
    "in vec2 envsh_uv;\n",
    "layout(location = 0) out uvec4 envsh_out_place;\n",
    "layout(location = 1) out uvec4 envsh_out_normal;\n",
    "layout(location = 2) out uvec4 envsh_out_flat;\n",
    "layout(location = 3) out uvec4 envsh_out_color;\n",
    "\n",
    "vec3 envsh_unit(vec3 v)\n",
    "{\n",
    "    float d = dot(v, v);\n",
    "    return d > 0.0 ? v * inversesqrt(d) : vec3(0.0);\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    vec4 color = glbk_envsh_object.color;\n",
    "    vec3 flat_n = envsh_unit(cross(dFdx(envsh_at), dFdy(envsh_at)));\n",
    "    if (dot(flat_n, flat_n) == 0.0) flat_n = envsh_unit(envsh_facing);      // so far out, all one place\n",
    "    if (dot(flat_n, glbk_envsh_object.eye.xyz - envsh_at) < 0.0) flat_n = -flat_n;\n",
    "    vec3 n = dot(envsh_facing, envsh_facing) > 0.0 ? envsh_unit(envsh_facing) : flat_n;\n",
    "    if (dot(n, flat_n) < 0.0) n = -n;\n",
    "    if (glbk_envsh_object.lights.z != 0u) color *= texture(glbk_envsh_color_map, envsh_uv);\n",
    "    if (color.a < glbk_envsh_object.eye.w) discard;\n",
    "    envsh_out_place = floatBitsToUint(vec4(envsh_at, 1.0));\n",
    "    envsh_out_normal = floatBitsToUint(vec4(n, 0.0));\n",
    "    envsh_out_flat = floatBitsToUint(vec4(flat_n, 0.0));\n",
    "    envsh_out_color = floatBitsToUint(vec4(color.rgb, 0.0));\n",
    "}\n"
};

static const char *const glbk__glsl_prog_envsh_gbuffer_vert[] = {
    "// Attributes 0 position, 1 normal, 2 texture coordinates.\n",
    "// uses: envsh_bindings\n",
    "layout(location = 0) in vec3 position;\n",
    "layout(location = 1) in vec3 normal;\n",
    "layout(location = 2) in vec2 uv;\n",
    "out vec3 envsh_at, envsh_facing;\n",
    "out vec2 envsh_uv;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    mat3 m = mat3(glbk_envsh_object.world);\n",
    "    envsh_at = (glbk_envsh_object.world * vec4(position, 1.0)).xyz;\n",
    "    envsh_facing = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * normal;\n",
    "    envsh_uv = uv;\n",
    "    gl_Position = glbk_envsh_object.clip * vec4(envsh_at, 1.0);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_envsh_resolve_frag[] = {
    "// Irradiance times albedo / pi, as colours.\n",
    "// uses: envsh_bindings\n",
    "// with: screen.vert\n",
    "layout(location = 0) out vec4 result;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy) - ivec2(glbk_envsh_object.lights.xy);\n",
    "    vec3 albedo = uintBitsToFloat(texelFetch(glbk_envsh_color, at, 0).xyz);\n",
    "    vec3 sum = glbk_envsh_object.lights.w != 0u ? glbk_unpack(texelFetch(glbk_envsh_sum, at, 0)).xyz : vec3(0.0);\n",
    "    result = vec4(sum * albedo * 0.318309886, 1.0);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_envsh_shade_comp[] = {
    "// envsh_shade.frag as a compute shader, all lights with the sum in registers. Each group of 8 x 8 pixels takes 64\n",
    "// lights at a time into shared memory; thread i finds out for light i whether it is under all normals of the group, lit\n",
    "// or dark all over it by the cells, and only what is left is asked for pixel by pixel.\n",
    "// uses: envsh_chunk envsh_light envsh_group\n",
    "// sets: ENVSH_FILTER=0 ENVSH_RGBA=0 | ENVSH_FILTER=1 ENVSH_RGBA=1 | ENVSH_FILTER=2 ENVSH_RGBA=0 | ENVSH_FILTER=3 ENVSH_RGBA=1\n",
    "layout(local_size_x = 8, local_size_y = 8) in;\n",
    "\n",
    "shared uint envsh_all_lit[2], envsh_asked[2];   // lights of the chunk, a bit each\n",
    "\n",
    "struct envsh_pixel { bool seen; vec3 p, n, flat_n; };\n",
    "\n",
    "// Bounds as least values of p, n, flat_n and of what they are negated, halved six times where the chunk will be.\n",
    "envsh_group envsh_bounds(envsh_pixel pixel)\n",
    "{\n",
    "    uint thread = gl_LocalInvocationIndex;\n",
    "    vec3 values[6] = vec3[6](pixel.p, pixel.n, pixel.flat_n, -pixel.p, -pixel.n, -pixel.flat_n);\n",
    "    for (uint i = 0u; i < 6u; i++)\n",
    "        envsh_chunk[64u * i + thread] = floatBitsToUint(vec4(pixel.seen ? values[i] : vec3(3e38), 0.0));\n",
    "    for (uint left = 32u; left > 0u; left >>= 1) {\n",
    "        barrier();\n",
    "        for (uint i = thread; thread < left && i < 384u; i += 64u) {\n",
    "            vec4 a = uintBitsToFloat(envsh_chunk[i]), b = uintBitsToFloat(envsh_chunk[i + left]);\n",
    "            envsh_chunk[i] = floatBitsToUint(min(a, b));\n",
    "        }\n",
    "    }\n",
    "    barrier();\n",
    "    for (uint i = 0u; i < 6u; i++) values[i] = uintBitsToFloat(envsh_chunk[64u * i].xyz);\n",
    "    return envsh_group(values[0], -values[3], values[1], -values[4], values[2], -values[5]);\n",
    "}\n",
    "\n",
    "void envsh_sort_lights(envsh_query q, envsh_group g, uint from, uint to)\n",
    "{\n",
    "    uint thread = gl_LocalInvocationIndex, bit = 1u << (thread & 31u);\n",
    "    barrier();                                  // the chunk is no longer read\n",
    "    envsh_load_chunk(from, to);\n",
    "    if (thread < 2u) envsh_all_lit[thread] = envsh_asked[thread] = 0u;\n",
    "    barrier();\n",
    "    if (from + thread < to) {\n",
    "        int known = envsh_group_visible(q, g, from + thread);\n",
    "        if (known > 0) atomicOr(envsh_all_lit[thread >> 5], bit);\n",
    "        if (known < 0) atomicOr(envsh_asked[thread >> 5], bit);\n",
    "    }\n",
    "    barrier();\n",
    "}\n",
    "\n",
    "// The first of those bits, which is taken away.\n",
    "uint envsh_take(inout uvec2 left)\n",
    "{\n",
    "    uint half_of = left.x != 0u ? 0u : 1u, bit = uint(findLSB(left[half_of]));\n",
    "    left[half_of] &= left[half_of] - 1u;\n",
    "    return 32u * half_of + bit;\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = textureSize(glbk_envsh_place, 0);\n",
    "    uvec4 range = glbk_envsh_query.range;       // lights from, to; width; 0 = the sum begins here\n",
    "    uint index = uint(at.y) * range.z + uint(at.x);\n",
    "    bool inside = all(lessThan(at, size));\n",
    "    envsh_query q = envsh_bound_query();\n",
    "    envsh_pixel pixel;\n",
    "    vec4 place = inside ? uintBitsToFloat(texelFetch(glbk_envsh_place, at, 0)) : vec4(0.0);\n",
    "    pixel.seen = place.w > 0.0;\n",
    "    pixel.p = place.xyz;\n",
    "    pixel.n = pixel.seen ? uintBitsToFloat(texelFetch(glbk_envsh_normal, at, 0).xyz) : vec3(0.0);\n",
    "    pixel.flat_n = pixel.seen ? uintBitsToFloat(texelFetch(glbk_envsh_flat, at, 0).xyz) : vec3(0.0);\n",
    "    envsh_group g = envsh_bounds(pixel);\n",
    "    uint to = g.low.x < 3e38 ? range.y : range.x;       // no light where nothing is seen\n",
    "    vec3 sum = inside && range.w != 0u ? imageLoad(glbk_envsh_total, at).xyz : vec3(0.0);\n",
    "    for (uint from = range.x; from < to; from += 64u) {\n",
    "        envsh_sort_lights(q, g, from, to);\n",
    "        for (uvec2 left = uvec2(envsh_all_lit[0], envsh_all_lit[1]); left != uvec2(0u);) {\n",
    "            uint light = from + envsh_take(left);\n",
    "            vec3 d = envsh_direction(light);\n",
    "            if (dot(pixel.flat_n, d) > 0.0) sum += max(dot(pixel.n, d), 0.0) * envsh_power(light);\n",
    "        }\n",
    "        for (uvec2 left = uvec2(envsh_asked[0], envsh_asked[1]); left != uvec2(0u);) {\n",
    "            uint light = from + envsh_take(left);\n",
    "            sum += envsh_irradiance(q, light, light + 1u, pixel.p, pixel.n, pixel.flat_n, index);\n",
    "        }\n",
    "    }\n",
    "    if (inside) imageStore(glbk_envsh_total, at, vec4(sum, 0.0));\n",
    "}\n"
};

static const char *const glbk__glsl_prog_envsh_shade_frag[] = {
    "// Adds the light of some lights to the irradiance of each pixel.\n",
    "// uses: envsh_light\n",
    "// with: screen.vert\n",
    "// sets: ENVSH_FILTER=0 ENVSH_RGBA=0 | ENVSH_FILTER=1 ENVSH_RGBA=1 | ENVSH_FILTER=2 ENVSH_RGBA=0 | ENVSH_FILTER=3 ENVSH_RGBA=1\n",
    "layout(location = 0) out glbk_color result;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n",
    "    uvec4 range = glbk_envsh_query.range;       // lights from, to; width; 0 = the sum begins here\n",
    "    vec3 sum = range.w != 0u ? glbk_unpack(texelFetch(glbk_envsh_sum, at, 0)).xyz : vec3(0.0);\n",
    "    vec4 place = uintBitsToFloat(texelFetch(glbk_envsh_place, at, 0));\n",
    "    if (place.w > 0.0) {\n",
    "        vec3 n = uintBitsToFloat(texelFetch(glbk_envsh_normal, at, 0).xyz);\n",
    "        vec3 flat_n = uintBitsToFloat(texelFetch(glbk_envsh_flat, at, 0).xyz);\n",
    "        uint index = uint(at.y) * range.z + uint(at.x);\n",
    "        sum += envsh_irradiance(envsh_bound_query(), range.x, range.y, place.xyz, n, flat_n, index);\n",
    "    }\n",
    "    result = glbk_pack(vec4(sum, 0.0));\n",
    "}\n"
};

static const char *const glbk__glsl_prog_ism_blur_comp[] = {
    "// ism_blur.frag as a compute shader: what a group of 16 x 16 pixels looks at, up to four more at each side, is in\n",
    "// shared memory.\n",
    "// uses: ism_blur\n",
    "layout(local_size_x = 16, local_size_y = 16) in;\n",
    "#define ISM_TILE 24\n",
    "\n",
    "shared vec3 ism_places[ISM_TILE * ISM_TILE], ism_normals[ISM_TILE * ISM_TILE];      // normal 0: nothing\n",
    "shared vec4 ism_lights[ISM_TILE * ISM_TILE];\n",
    "\n",
    "ivec2 ism_corner() { return ivec2(gl_WorkGroupID.xy) * 16 - int(glbk_ism_view.size.z) / 2; }\n",
    "\n",
    "bool ism_neighbour(ivec2 at, out ism_receiver r, out vec4 light)\n",
    "{\n",
    "    ivec2 texel = at - ism_corner();\n",
    "    int i = texel.y * ISM_TILE + texel.x;\n",
    "    r.p = ism_places[i];\n",
    "    r.n = r.ng = ism_normals[i];\n",
    "    light = ism_lights[i];\n",
    "    return r.n != vec3(0.0);\n",
    "}\n",
    "\n",
    "void ism_load(int wide)\n",
    "{\n",
    "    for (int i = int(gl_LocalInvocationIndex); i < wide * wide; i += 256) {\n",
    "        ivec2 texel = ivec2(i % wide, i / wide), at = ism_corner() + texel;\n",
    "        int to = texel.y * ISM_TILE + texel.x;\n",
    "        ism_receiver r;\n",
    "        ism_normals[to] = vec3(0.0);\n",
    "        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(glbk_ism_view.size.xy)))) continue;\n",
    "        if (!ism_read_receiver(at, r)) continue;\n",
    "        ism_places[to] = r.p;\n",
    "        ism_normals[to] = r.n;\n",
    "        ism_lights[to] = texelFetch(glbk_ism_light, at, 0);\n",
    "    }\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_GlobalInvocationID.xy);\n",
    "    int side = int(glbk_ism_view.size.z);\n",
    "    ism_receiver c;\n",
    "    if (side > 1) ism_load(16 + side / 2 * 2);\n",
    "    barrier();\n",
    "    if (any(greaterThanEqual(at, ivec2(glbk_ism_view.size.xy)))) return;\n",
    "    imageStore(glbk_ism_light_out, at, ism_read_receiver(at, c) ? ism_finished(at, c) : vec4(0.0));\n",
    "}\n"
};

static const char *const glbk__glsl_prog_ism_blur_frag[] = {
    "// The blur over the classes of pixels, and the albedo.\n",
    "// uses: ism_blur\n",
    "// with: screen.vert\n",
    "layout(location = 0) out glbk_color result;\n",
    "\n",
    "bool ism_neighbour(ivec2 at, out ism_receiver r, out vec4 light)\n",
    "{\n",
    "    bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(glbk_ism_view.size.xy)));\n",
    "    if (!inside || !ism_read_receiver(at, r)) return false;\n",
    "    light = glbk_unpack(texelFetch(glbk_ism_light, at, 0));\n",
    "    return true;\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n",
    "    ism_receiver c;\n",
    "    result = glbk_pack(ism_read_receiver(at, c) ? ism_finished(at, c) : vec4(0.0));\n",
    "}\n"
};

static const char *const glbk__glsl_prog_ism_fill_comp[] = {
    "// Holes, all levels of pull, and push, in one pass: a group has a whole tile in shared memory, or of larger tiles 32 x 32\n",
    "// texels and 16 more at each side, of which eight may keep surfels. An invocation has 16 of these 64 x 64 texels.\n",
    "// uses: ism_holes ism_push\n",
    "// sets: ISM_PROJECTION=1 | ISM_PROJECTION=4\n",
    "layout(local_size_x = 256) in;\n",
    "#define ISM_SIDE 64\n",
    "\n",
    "shared float ism_depths[ISM_SIDE * ISM_SIDE];       // of surfels that are kept, else ISM_FAR\n",
    "shared uint ism_cells[1024 + 256 + 64];             // of the levels, one after the other\n",
    "ivec2 ism_origin;                                   // of those texels, in the atlas\n",
    "\n",
    "uint ism_cell(int level, ivec2 cell)\n",
    "{\n",
    "    uint wide = uint(ISM_SIDE >> level), first = level == 1 ? 0u : level == 2 ? 1024u : 1280u;\n",
    "    return first + uint(cell.y) * wide + uint(cell.x);\n",
    "}\n",
    "\n",
    "ivec2 ism_texel(uint i) { return ivec2(i % uint(ISM_SIDE), i / uint(ISM_SIDE)); }\n",
    "\n",
    "float ism_depth(ivec2 at)\n",
    "{\n",
    "    ivec2 texel = at - ism_origin;\n",
    "    return ism_depths[texel.y * ISM_SIDE + texel.x];\n",
    "}\n",
    "\n",
    "int ism_pulled(int level, ivec2 cell) { return int(ism_cells[ism_cell(level, cell - (ism_origin >> level))]); }\n",
    "\n",
    "// 1 or the number of a part's texel: level 0 are the texels that are kept.\n",
    "uint ism_part(int level, ivec2 cell)\n",
    "{\n",
    "    if (level == 0) return ism_depths[cell.y * ISM_SIDE + cell.x] < ISM_FAR ? 1u : 0u;\n",
    "    return ism_cells[ism_cell(level, cell)];\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    int size = int(glbk_ism_frame.maps.y), levels = int(glbk_ism_frame.points.z);\n",
    "    int block = size > ISM_SIDE ? 32 : size, margin = size > ISM_SIDE ? 16 : 0;\n",
    "    ivec2 begin = ivec2(gl_WorkGroupID.xy) * block, tile = begin - (begin & (size - 1));\n",
    "    uint v = ism_tile_of(begin), holes = 0u;\n",
    "    bool used = v < glbk_ism_frame.maps.x;\n",
    "    ism_grid grid = ism_read_grid(used ? v : 0u);\n",
    "    ism_origin = begin - margin;\n",
    "    for (uint i = gl_LocalInvocationIndex; i < uint(ISM_SIDE * ISM_SIDE); i += 256u) {\n",
    "        ivec2 at = ism_origin + ism_texel(i), local = at - tile;\n",
    "        bool inside = used && all(greaterThanEqual(local, ivec2(0))) && all(lessThan(local, ivec2(size)));\n",
    "        ism_depths[i] = inside ? ism_surfel_at(at).w : ISM_FAR;\n",
    "    }\n",
    "    barrier();\n",
    "    for (uint k = 0u; k < 16u && levels != 0; k++) {\n",
    "        ivec2 texel = ism_texel(gl_LocalInvocationIndex + 256u * k);\n",
    "        float depth = ism_depth(ism_origin + texel);\n",
    "        bool near_by = all(greaterThanEqual(texel, ivec2(margin / 2))) && all(lessThan(texel, ivec2(ISM_SIDE - margin / 2)));\n",
    "        if (near_by && depth < ISM_FAR && ism_hole(grid, ism_origin + texel, depth)) holes |= 1u << k;\n",
    "    }\n",
    "    barrier();\n",
    "    for (uint k = 0u; k < 16u; k++)\n",
    "        if ((holes >> k & 1u) != 0u) ism_depths[gl_LocalInvocationIndex + 256u * k] = ISM_FAR;\n",
    "    for (int level = 1; level <= levels; level++) {\n",
    "        int wide = ISM_SIDE >> level;\n",
    "        barrier();\n",
    "        for (int i = int(gl_LocalInvocationIndex); i < wide * wide; i += 256) {\n",
    "            ivec2 cell = ivec2(i % wide, i / wide);\n",
    "            uvec4 parts;\n",
    "            for (int k = 0; k < 4; k++) parts[k] = ism_part(level - 1, 2 * cell + ivec2(k & 1, k >> 1));\n",
    "            ism_cells[ism_cell(level, cell)] = ism_pull(level, cell + ((ism_origin - tile) >> level), parts);\n",
    "        }\n",
    "    }\n",
    "    barrier();\n",
    "    for (uint i = gl_LocalInvocationIndex; i < uint(block * block); i += 256u) {\n",
    "        ivec2 at = begin + ivec2(i % uint(block), i / uint(block));\n",
    "        float depth = ism_depth(at);\n",
    "        if (used && levels != 0 && !(depth < ISM_FAR)) depth = ism_filled(grid, at);\n",
    "        imageStore(glbk_ism_atlas_out, at, uvec4(floatBitsToUint(depth), 0u, 0u, 0u));\n",
    "    }\n",
    "}\n"
};

static const char *const glbk__glsl_prog_ism_holes_frag[] = {
    "// 1 where a texel keeps its surfel, 0 where it is empty or a hole.\n",
    "// uses: ism_holes\n",
    "// with: screen.vert\n",
    "// sets: ISM_PROJECTION=1 | ISM_PROJECTION=4\n",
    "layout(location = 0) out uint result;\n",
    "\n",
    "float ism_depth(ivec2 at) { return ism_surfel_at(at).w; }\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n",
    "    uint v = ism_tile_of(at);\n",
    "    float depth = ism_depth(at);\n",
    "    result = 0u;\n",
    "    if (!(depth < ISM_FAR) || v >= glbk_ism_frame.maps.x) return;\n",
    "    result = glbk_ism_frame.points.z != 0u && ism_hole(ism_read_grid(v), at, depth) ? 0u : 1u;\n",
    "}\n"
};

static const char *const glbk__glsl_prog_ism_pull_frag[] = {
    "// A cell of 2^ISM_LEVEL texels a side: 1 + the index in its tile of one texel of its four parts.\n",
    "// uses: ism_fill\n",
    "// with: screen.vert\n",
    "// sets: ISM_LEVEL=1 | ISM_LEVEL=2 | ISM_LEVEL=3\n",
    "#ifndef ISM_LEVEL\n",
    "#define ISM_LEVEL 1\n",
    "#endif\n",
    "layout(location = 0) out uint result;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 cell = ivec2(gl_FragCoord.xy);\n",
    "    uvec4 parts;\n",
    "    for (int k = 0; k < 4; k++) parts[k] = texelFetch(glbk_ism_below, 2 * cell + ivec2(k & 1, k >> 1), 0).x;\n",
    "    result = ism_pull(ISM_LEVEL, cell & ((int(glbk_ism_frame.maps.y) >> ISM_LEVEL) - 1), parts);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_ism_push_frag[] = {
    "// The depth of a texel, as bits: its surfel's, or from others about it.\n",
    "// uses: ism_push\n",
    "// with: screen.vert\n",
    "// sets: ISM_PROJECTION=1 | ISM_PROJECTION=4\n",
    "layout(location = 0) out uint result;\n",
    "\n",
    "int ism_pulled(int level, ivec2 cell)\n",
    "{\n",
    "    uint at = level == 1 ? texelFetch(glbk_ism_pull1, cell, 0).x : level == 2 ? texelFetch(glbk_ism_pull2, cell, 0).x\n",
    "                                                                              : texelFetch(glbk_ism_pull3, cell, 0).x;\n",
    "    return int(at);\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n",
    "    uint v = ism_tile_of(at);\n",
    "    float depth = ISM_FAR;\n",
    "    if (texelFetch(glbk_ism_below, at, 0).x != 0u) depth = ism_surfel_at(at).w;\n",
    "    else if (glbk_ism_frame.points.z != 0u && v < glbk_ism_frame.maps.x) depth = ism_filled(ism_read_grid(v), at);\n",
    "    result = floatBitsToUint(depth);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_ism_resolve_frag[] = {
    "// Radiance of glbk_ism_shade, as colours.\n",
    "// uses: ism_bindings\n",
    "// with: screen.vert\n",
    "layout(location = 0) out vec4 result;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy) - ivec2(glbk_ism_view.size.xy);\n",
    "    result = glbk_unpack(texelFetch(glbk_ism_light, at, 0));\n",
    "}\n"
};

static const char *const glbk__glsl_prog_ism_shade_comp[] = {
    "// ism_shade.frag as a compute shader: a group has 16 x 16 pixels of one class, which lie `pattern` apart, and reads each\n",
    "// VPL of the class once, into shared memory, 64 at a time.\n",
    "// uses: ism_gbuffer ism_light\n",
    "// sets: ISM_PROJECTION=1 ISM_NEAR=1 | ISM_PROJECTION=2 ISM_NEAR=2 | ISM_PROJECTION=3 ISM_NEAR=3 | ISM_PROJECTION=4 ISM_NEAR=4 | ISM_NEAR=5 | ISM_NEAR=6\n",
    "layout(local_size_x = 16, local_size_y = 16) in;\n",
    "#define ISM_ROUND 64u\n",
    "\n",
    "shared ism_vpl ism_read[ISM_ROUND];\n",
    "\n",
    "// The VPLs from number `from` of the class on; how many.\n",
    "uint ism_round(uint first, uint pattern, uint used, uint from)\n",
    "{\n",
    "    uint k = gl_LocalInvocationIndex, count = min(used - from, ISM_ROUND);\n",
    "    barrier();\n",
    "    if (k < count) ism_read[k] = ism_read_vpl(first + (from + k) * pattern);\n",
    "    barrier();\n",
    "    return count;\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    uint side = glbk_ism_view.size.z, pattern = side * side, first = gl_WorkGroupID.z, used = ism_used(first, pattern);\n",
    "    ivec2 at = ivec2(gl_GlobalInvocationID.xy * side + uvec2(first % side, first / side));\n",
    "    at.y += int(glbk_ism_view.values.z);        // the first row of this dispatch\n",
    "    bool inside = all(lessThan(at, ivec2(glbk_ism_view.size.xy)));\n",
    "    float most = glbk_ism_view.values.y;\n",
    "    vec4 sum = vec4(0.0);\n",
    "    ism_receiver r;\n",
    "    bool lit = inside && ism_read_receiver(at, r);\n",
    "#if ISM_NEAR == 4\n",
    "    float all_of_them = 0.0;\n",
    "    for (uint from = 0u; from < used; from += ISM_ROUND) {\n",
    "        uint count = ism_round(first, pattern, used, from);\n",
    "        for (uint k = 0u; k < count && lit; k++) all_of_them += ism_unshadowed(ism_read[k], r.p, r.n);\n",
    "    }\n",
    "    most *= used > 0u ? all_of_them / float(used) : 0.0;\n",
    "#endif\n",
    "    for (uint from = 0u; from < used; from += ISM_ROUND) {\n",
    "        uint count = ism_round(first, pattern, used, from);\n",
    "        for (uint k = 0u; k < count && lit; k++)\n",
    "            ism_add(sum, first + (from + k) * pattern, ism_read[k], r.p, r.n, r.ng, most);\n",
    "    }\n",
    "    sum = ism_scaled(sum, pattern);\n",
    "#if ISM_NEAR == 6\n",
    "    if (lit) sum += ism_gather(r.p, r.n, r.ng, first, pattern);\n",
    "#endif\n",
    "    if (inside) imageStore(glbk_ism_light_out, at, sum);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_ism_shade_frag[] = {
    "// Each pixel by its own class of VPLs: every pattern^2-th of them (interleaved sampling, paper 6.2).\n",
    "// uses: ism_gbuffer ism_light\n",
    "// with: screen.vert\n",
    "// sets: ISM_PROJECTION=1 ISM_NEAR=1 | ISM_PROJECTION=2 ISM_NEAR=2 | ISM_PROJECTION=3 ISM_NEAR=3 | ISM_PROJECTION=4 ISM_NEAR=4 | ISM_NEAR=5 | ISM_NEAR=6\n",
    "layout(location = 0) out glbk_color result;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n",
    "    uint side = glbk_ism_view.size.z;\n",
    "    uvec2 place = uvec2(at) % side;\n",
    "    ism_receiver r;\n",
    "    vec4 light = vec4(0.0);\n",
    "    if (ism_read_receiver(at, r)) light = ism_light(r.p, r.n, r.ng, place.y * side + place.x, side * side);\n",
    "    result = glbk_pack(light);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_ism_splat_comp[] = {
    "// ism_splat.vert and .frag as a compute shader: a group draws all points of a VPL into up to 64 x 64 texels of its tile\n",
    "// in shared memory, twice: first the depths alone, then which point it is that has them, the first one of several, as\n",
    "// the depth test has it. Discs of many texels go to a list that 32 invocations a disc draw, so that no 31 wait for one.\n",
    "// uses: ism_disc\n",
    "// sets: ISM_PROJECTION=1 | ISM_PROJECTION=4\n",
    "layout(local_size_x = 512) in;\n",
    "#define ISM_THREADS 512u\n",
    "#define ISM_SIDE 64\n",
    "#define ISM_WIDE 64         // texels: discs of more go to the list\n",
    "#define ISM_LIST 112u       // discs: what 32 KiB leave\n",
    "#define ISM_HOPE 0x80000000u\n",
    "\n",
    "shared uint ism_depths[ISM_SIDE * ISM_SIDE];            // as bits, which are in the order of positive floats\n",
    "shared uint ism_owners[ISM_SIDE * ISM_SIDE / 2];        // 16 bits each: maps of more points are not drawn by compute\n",
    "shared vec4 ism_list[4u * ISM_LIST];                    // at, radius2; g; cut1; cut2\n",
    "shared uint ism_numbers[ISM_LIST], ism_listed;\n",
    "shared uint ism_boxes[ISM_LIST];                        // four bytes; the highest bit: it was the nearest once\n",
    "\n",
    "uint ism_v;             // the VPL\n",
    "ism_vpl ism_l;\n",
    "ivec4 ism_part;         // first and last texel, of its tile\n",
    "uint ism_hopes[4];      // bits: which of this invocation's points had a texel once\n",
    "\n",
    "// Point number i of the VPL, phase after phase, with its texels in this part; false: it has none.\n",
    "bool ism_find(uint i, out ism_surfel s)\n",
    "{\n",
    "    uint each = glbk_ism_frame.points.y;\n",
    "    if (!ism_surfel_of((i / each * glbk_ism_frame.points.x + ism_v) * each + i % each, ism_v, ism_l, s)) return false;\n",
    "    s.box = ivec4(max(s.box.xy, ism_part.xy), min(s.box.zw, ism_part.zw));\n",
    "    return s.box.x <= s.box.z && s.box.y <= s.box.w;\n",
    "}\n",
    "\n",
    "uint ism_owner(uint texel) { return ism_owners[texel >> 1] >> (16u * (texel & 1u)) & 0xffffu; }\n",
    "\n",
    "// The atomic minimum of 16 bits.\n",
    "void ism_own(uint texel, uint point)\n",
    "{\n",
    "    uint shift = 16u * (texel & 1u), was = ism_owners[texel >> 1];\n",
    "    while ((was >> shift & 0xffffu) > point) {\n",
    "        uint now = atomicCompSwap(ism_owners[texel >> 1], was, (was & ~(0xffffu << shift)) | point << shift);\n",
    "        if (now == was) break;\n",
    "        was = now;\n",
    "    }\n",
    "}\n",
    "\n",
    "// Its texels from the one at `from` on, every `pace`th; one loop, which those who draw beside it leave together. true: it\n",
    "// was the nearest in one of them.\n",
    "bool ism_draw(int turn, uint i, ism_surfel s, ivec2 from, ivec2 pace)\n",
    "{\n",
    "    ivec2 at = s.box.xy + from;\n",
    "    bool nearest = false;\n",
    "    while (at.x <= s.box.z && at.y <= s.box.w) {\n",
    "        uint texel = uint((at.y - ism_part.y) * ISM_SIDE + at.x - ism_part.x), depth = ism_depths[texel];\n",
    "        float t = ism_meet(ism_l.sky, s, ism_texel_direction(ism_l.grid, at), uintBitsToFloat(depth));\n",
    "        if (t < ISM_FAR) {\n",
    "            if (turn == 0) nearest = atomicMin(ism_depths[texel], floatBitsToUint(t)) >= floatBitsToUint(t) || nearest;\n",
    "            else if (depth == floatBitsToUint(t)) ism_own(texel, i);\n",
    "        }\n",
    "        at.x += pace.x;\n",
    "        if (at.x > s.box.z) at = ivec2(s.box.x + from.x, at.y + pace.y);\n",
    "    }\n",
    "    return nearest;\n",
    "}\n",
    "\n",
    "uint ism_pack(ivec4 box)\n",
    "{\n",
    "    uvec4 b = uvec4(box - ism_part.xyxy);\n",
    "    return b.x | b.y << 8 | b.z << 16 | b.w << 24;\n",
    "}\n",
    "\n",
    "ism_surfel ism_unlist(uint k)\n",
    "{\n",
    "    vec4 a = ism_list[4u * k], b = ism_list[4u * k + 1u];\n",
    "    uint box = ism_boxes[k];\n",
    "    ivec4 texels = ivec4(box & 63u, box >> 8 & 63u, box >> 16 & 63u, box >> 24 & 63u) + ism_part.xyxy;\n",
    "    return ism_surfel(a.xyz, b.xyz, a.w, 0.0, vec2(0.0), ism_list[4u * k + 2u], ism_list[4u * k + 3u], texels);\n",
    "}\n",
    "\n",
    "// The discs that invocations have for the list, as many at a time as it holds. true: this one's was the nearest in a\n",
    "// texel. All invocations come here.\n",
    "bool ism_draw_list(int turn, uint i, ism_surfel s, bool waits)\n",
    "{\n",
    "    uint thread = gl_LocalInvocationIndex, count;\n",
    "    bool nearest = false;\n",
    "    do {\n",
    "        uint k = waits ? atomicAdd(ism_listed, 1u) : ISM_LIST;\n",
    "        bool listed = k < ISM_LIST;\n",
    "        if (listed) {\n",
    "            ism_list[4u * k] = vec4(s.at, s.radius2);\n",
    "            ism_list[4u * k + 1u] = vec4(s.g, 0.0);\n",
    "            ism_list[4u * k + 2u] = s.cut1;\n",
    "            ism_list[4u * k + 3u] = s.cut2;\n",
    "            ism_boxes[k] = ism_pack(s.box);\n",
    "            ism_numbers[k] = i;\n",
    "        }\n",
    "        waits = waits && !listed;\n",
    "        barrier();\n",
    "        count = ism_listed;\n",
    "        for (uint d = thread / 32u; d < min(count, ISM_LIST); d += ISM_THREADS / 32u)\n",
    "            if (ism_draw(turn, ism_numbers[d], ism_unlist(d), ivec2(thread & 7u, thread / 8u & 3u), ivec2(8, 4)))\n",
    "                atomicOr(ism_boxes[d], ISM_HOPE);\n",
    "        barrier();\n",
    "        if (thread == 0u) ism_listed = 0u;\n",
    "        if (listed && (ism_boxes[k] & ISM_HOPE) != 0u) nearest = true;\n",
    "        barrier();\n",
    "    } while (count > ISM_LIST);\n",
    "    return nearest;\n",
    "}\n",
    "\n",
    "// Of each invocation a point at a time. The second turn passes by those that had no texel in the first.\n",
    "void ism_draw_all(int turn, uint count)\n",
    "{\n",
    "    for (uint start = 0u; start < count; start += ISM_THREADS) {\n",
    "        uint i = start + gl_LocalInvocationIndex, word = start / ISM_THREADS >> 5, bit = 1u << (start / ISM_THREADS & 31u);\n",
    "        ism_surfel s;\n",
    "        bool there = i < count && (turn == 0 || (ism_hopes[word] & bit) != 0u) && ism_find(i, s);\n",
    "        ivec2 wide = there ? s.box.zw - s.box.xy + 1 : ivec2(0);\n",
    "        bool waits = wide.x * wide.y > ISM_WIDE;\n",
    "        bool nearest = there && !waits && ism_draw(turn, i, s, ivec2(0), ivec2(1));\n",
    "        if (ism_draw_list(turn, i, s, waits) || nearest) ism_hopes[word] |= bit;\n",
    "    }\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    uint thread = gl_LocalInvocationIndex, count;\n",
    "    int side = min(int(glbk_ism_frame.maps.y), ISM_SIDE);\n",
    "    ivec2 begin = ivec2(gl_WorkGroupID.xy) * side;\n",
    "    ism_surfel s;\n",
    "    ism_hopes = uint[4](0u, 0u, 0u, 0u);\n",
    "    ism_v = ism_tile_of(begin);\n",
    "    ism_part = (begin - ism_tile_at(ism_v)).xyxy + ivec4(0, 0, side - 1, side - 1);\n",
    "    count = ism_v < glbk_ism_frame.maps.x && glbk_ism_frame.points.w != 0u ? glbk_ism_frame.maps.w : 0u;\n",
    "    ism_l = ism_read_vpl(min(ism_v, glbk_ism_frame.points.x - 1u));\n",
    "    for (uint i = thread; i < uint(ISM_SIDE * ISM_SIDE); i += ISM_THREADS) {\n",
    "        ism_depths[i] = floatBitsToUint(ISM_FAR);\n",
    "        ism_owners[i >> 1] = 0xffffffffu;\n",
    "    }\n",
    "    if (thread == 0u) ism_listed = 0u;\n",
    "    barrier();\n",
    "    for (int turn = 0; turn < 2; turn++) ism_draw_all(turn, count);\n",
    "    for (uint i = thread; i < uint(ISM_SIDE * ISM_SIDE); i += ISM_THREADS) {\n",
    "        ivec2 texel = ivec2(i % uint(ISM_SIDE), i / uint(ISM_SIDE));\n",
    "        vec4 surfel = vec4(0.0, 0.0, 0.0, ISM_FAR);\n",
    "        if (max(texel.x, texel.y) >= side) continue;\n",
    "        if (ism_depths[i] != floatBitsToUint(ISM_FAR) && ism_find(ism_owner(i), s))\n",
    "            surfel = vec4(s.g, uintBitsToFloat(ism_depths[i]));\n",
    "        imageStore(glbk_ism_surfels_out, begin + texel, surfel);\n",
    "    }\n",
    "}\n"
};

static const char *const glbk__glsl_prog_ism_splat_frag[] = {
    "// A texel whose ray meets the disc gets its plane and its depth there.\n",
    "// uses: ism_disc\n",
    "// with: ism_splat.vert\n",
    "// sets: ISM_PROJECTION=1 ISM_QUADS=0 | ISM_PROJECTION=4 ISM_QUADS=1\n",
    "flat in vec4 ism_at;\n",
    "flat in vec4 ism_plane;\n",
    "flat in vec4 ism_across;\n",
    "flat in vec4 ism_down;\n",
    "flat in ivec4 ism_box;\n",
    "flat in vec4 ism_cut1;\n",
    "flat in vec4 ism_cut2;\n",
    "layout(location = 0) out glbk_color result;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n",
    "    if (any(lessThan(at, ism_box.xy)) || any(greaterThan(at, ism_box.zw))) discard;\n",
    "    ism_surfel s = ism_surfel(ism_at.xyz, ism_plane.xyz, ism_at.w, 0.0, vec2(0.0), ism_cut1, ism_cut2, ism_box);\n",
    "    vec3 w = ism_texel_direction(ism_grid(ism_plane.w, ism_across, ism_down), at & (int(glbk_ism_frame.maps.y) - 1));\n",
    "    float t = ism_meet(ism_plane.w < 0.0, s, w, ISM_FAR);\n",
    "    if (!(t < ISM_FAR)) discard;\n",
    "    result = glbk_pack(vec4(ism_plane.xyz, t));\n",
    "    gl_FragDepth = t * 5.421010862427522e-20;      // 2^-64: every digit of t is kept\n",
    "}\n"
};

static const char *const glbk__glsl_prog_ism_splat_vert[] = {
    "// One point as a disc in the tile of its VPL: a point as large as the texels that it may touch, or with ISM_QUADS a\n",
    "// rectangle of them, one instance a point.\n",
    "// uses: ism_disc\n",
    "#ifndef ISM_QUADS\n",
    "#define ISM_QUADS 0\n",
    "#endif\n",
    "flat out vec4 ism_at;       // in the tile's frame; radius squared\n",
    "flat out vec4 ism_plane;    // its plane; exponent of the tile's grid\n",
    "flat out vec4 ism_across;   // the grid's axes\n",
    "flat out vec4 ism_down;\n",
    "flat out ivec4 ism_box;     // first and last texel\n",
    "flat out vec4 ism_cut1;\n",
    "flat out vec4 ism_cut2;\n",
    "\n",
    "void main()\n",
    "{\n",
    "#if ISM_QUADS\n",
    "    uint index = uint(gl_InstanceID) + glbk_ism_frame.near_points.w;\n",
    "#else\n",
    "    uint index = uint(gl_VertexID);\n",
    "    gl_PointSize = 1.0;\n",
    "#endif\n",
    "    uint v = index / glbk_ism_frame.points.y;       // the points of one phase are bound\n",
    "    ism_surfel s;\n",
    "    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);\n",
    "    ism_at = vec4(0.0);\n",
    "    ism_plane = vec4(0.0);\n",
    "    ism_across = ism_down = vec4(0.0);\n",
    "    ism_box = ivec4(0);\n",
    "    ism_cut1 = ism_cut2 = vec4(0.0);\n",
    "    if (v >= glbk_ism_frame.maps.x) return;\n",
    "    ism_vpl l = ism_read_vpl(v);\n",
    "    if (!ism_surfel_of(index, v, l, s)) return;\n",
    "    ism_at = vec4(s.at, s.radius2);\n",
    "    ism_plane = vec4(s.g, l.grid.exponent);\n",
    "    ism_across = l.grid.across;\n",
    "    ism_down = l.grid.down;\n",
    "    ism_cut1 = s.cut1;\n",
    "    ism_cut2 = s.cut2;\n",
    "    ism_box = s.box + ism_tile_at(v).xyxy;\n",
    "#if ISM_QUADS\n",
    "    vec2 at = vec2((gl_VertexID & 1) != 0 ? ism_box.z + 1 : ism_box.x, (gl_VertexID & 2) != 0 ? ism_box.w + 1 : ism_box.y);\n",
    "#else\n",
    "    vec2 at = 0.5 * vec2(ism_box.xy + ism_box.zw + 1);\n",
    "    ivec2 wide = s.box.zw - s.box.xy;\n",
    "    gl_PointSize = float(max(wide.x, wide.y) + 1);\n",
    "#endif\n",
    "    gl_Position = vec4(at / float(glbk_ism_frame.maps.y * glbk_ism_frame.maps.z) * 2.0 - 1.0, 0.0, 1.0);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_begin_comp[] = {
    "// Before interpolation: no node of the finest grid is evaluated, those of the first one are wanted where something is\n",
    "// seen.\n",
    "// uses: rsm_lists\n",
    "layout(local_size_x = 8, local_size_y = 8) in;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    int fine = int(glbk_rsm_frame.grid.y);\n",
    "    ivec2 number = ivec2(gl_GlobalInvocationID.xy), size = ivec2(glbk_rsm_frame.grid.zw), first;\n",
    "    ivec2 last = rsm_node_number(size - 1, fine), at = min(number * fine, size - 1);\n",
    "    rsm_receiver r;\n",
    "    rsm_begin_lists();\n",
    "    if (all(lessThanEqual(number, last))) {\n",
    "        uint i = rsm_mark(number, last);\n",
    "        if ((i & 31u) == 0u) glbk_rsm_marks[i >> 5] = 0u;\n",
    "        imageStore(glbk_rsm_nodes, number, vec4(0.0));\n",
    "        if (rsm_is_node(at, int(glbk_rsm_frame.grid.x), size, first) && rsm_read(at, r)) rsm_add_wanted(at);\n",
    "    }\n",
    "    rsm_end_lists(0u, glbk_rsm_frame.lists.z);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_direct_frag[] = {
    "// Adds the light of the bound map to the picture.\n",
    "// uses: rsm_direct rsm_screen\n",
    "// with: screen.vert\n",
    "layout(location = 0) out glbk_color result;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n",
    "    vec4 sum = glbk_rsm_frame.range.w != 0u ? glbk_unpack(texelFetch(glbk_rsm_sum, at, 0)) : vec4(0.0);\n",
    "    rsm_receiver r;\n",
    "    if (rsm_read(at, r))\n",
    "        sum += vec4(rsm_direct(rsm_bound(), r.position, r.normal, int(glbk_rsm_frame.counts.x), glbk_rsm_frame.limits.x,\n",
    "                               glbk_rsm_frame.limits.y), 1.0);\n",
    "    result = glbk_pack(sum);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_fill_frag[] = {
    "// One object into a face of a map (FOR_LIGHT=1) or into the G-buffer.\n",
    "// uses: rsm_bindings rsm_bound\n",
    "// with: rsm_fill.vert\n",
    "// sets: FOR_LIGHT=0 | FOR_LIGHT=1\n",
    "#ifndef FOR_LIGHT\n",
    "#define FOR_LIGHT 0\n",
    "#endif\n",
    "in vec3 rsm_place, rsm_facing;\n",
    "in vec2 rsm_uv;\n",
    "layout(location = 0) out uvec4 rsm_out_place;\n",
    "layout(location = 1) out uvec4 rsm_out_normal;\n",
    "layout(location = 2) out uvec4 rsm_out_flux;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    uvec4 kinds = glbk_rsm_drawn.kinds;        // material, has a map, face\n",
    "    vec4 albedo = glbk_rsm_drawn.albedo, eye = glbk_rsm_drawn.eye;\n",
    "    vec3 view = eye.w > 0.0 ? eye.xyz - rsm_place : eye.xyz;\n",
    "    vec3 flat_normal = rsm_normalize(cross(dFdx(rsm_place), dFdy(rsm_place)));\n",
    "    if (dot(flat_normal, flat_normal) == 0.0) flat_normal = rsm_normalize(rsm_facing);      // so far out, all one place\n",
    "    if (dot(flat_normal, view) < 0.0) flat_normal = -flat_normal;\n",
    "    vec3 n = dot(rsm_facing, rsm_facing) > 0.0 ? rsm_normalize(rsm_facing) : flat_normal;\n",
    "    if (dot(n, flat_normal) < 0.0) n = -n;\n",
    "    if (kinds.y != 0u) {\n",
    "        vec4 map = texture(glbk_rsm_albedo_map, rsm_uv);\n",
    "        if (textureLod(glbk_rsm_albedo_map, rsm_uv, 0.0).w < albedo.w) discard;\n",
    "        albedo.xyz *= map.xyz;\n",
    "    }\n",
    "#if FOR_LIGHT\n",
    "    rsm_lamp l = rsm_bound();\n",
    "    int face = int(kinds.z);\n",
    "    vec3 r, u, a, flux = rsm_incident(l, face, ivec2(gl_FragCoord.xy)) * l.value * albedo.xyz;\n",
    "    if (!(max(max(flux.x, flux.y), flux.z) <= 1e18)) flux = vec3(0.0);\n",
    "    rsm_face_frame(l, face, r, u, a);\n",
    "    float depth = dot(rsm_place - l.position, a);\n",
    "    gl_FragDepth = clamp((depth - glbk_rsm_drawn.range.x) * glbk_rsm_drawn.range.y, 0.0, 1.0);\n",
    "    rsm_out_place = floatBitsToUint(vec4(rsm_place, depth));\n",
    "    rsm_out_normal = uvec4(floatBitsToUint(n), kinds.x);\n",
    "    rsm_out_flux = floatBitsToUint(vec4(flux, rsm_area(l, face, rsm_place, n)));\n",
    "#else\n",
    "    rsm_out_place = floatBitsToUint(vec4(rsm_place, 1.0));\n",
    "    rsm_out_normal = uvec4(floatBitsToUint(n), kinds.x);\n",
    "    rsm_out_flux = floatBitsToUint(vec4(albedo.xyz, 0.0));\n",
    "#endif\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_fill_vert[] = {
    "// Attributes 0 position, 1 normal, 2 texture coordinates.\n",
    "// uses: rsm_bindings\n",
    "layout(location = 0) in vec3 position;\n",
    "layout(location = 1) in vec3 normal;\n",
    "layout(location = 2) in vec2 uv;\n",
    "out vec3 rsm_place, rsm_facing;\n",
    "out vec2 rsm_uv;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    mat3 m = mat3(glbk_rsm_drawn.world);\n",
    "    rsm_place = (glbk_rsm_drawn.world * vec4(position, 1.0)).xyz;\n",
    "    rsm_facing = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * normal;\n",
    "    rsm_uv = uv;\n",
    "    gl_Position = glbk_rsm_drawn.clip * vec4(rsm_place, 1.0);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_gather_comp[] = {
    "// rsm_gather.frag in place: sums in registers; lights and points, which all of a group take, through shared memory.\n",
    "// Mode 0: every pixel, a group has 8 x 8 of one set; 1: nodes of a list (NODES=1; else nothing asks how near lights are,\n",
    "// and a tenth of a pair's work is not done); 2: pixels of a list.\n",
    "// uses: rsm_chunk rsm_bounce rsm_lists\n",
    "// sets: NODES=0 | NODES=1 | NODES=0 RSM_SURFACES=1 | NODES=1 RSM_SURFACES=1\n",
    "#ifndef NODES\n",
    "#define NODES 0\n",
    "#endif\n",
    "layout(local_size_x = 64) in;\n",
    "shared bool rsm_awake;\n",
    "\n",
    "// rsm_bounce for all pixels of a group, of which those that are not awake only help to fetch.\n",
    "vec3 rsm_bounce_together(rsm_receiver r, ivec2 at, uint set, bool awake)\n",
    "{\n",
    "    uint i = gl_LocalInvocationIndex, sets = glbk_rsm_frame.counts.y * glbk_rsm_frame.counts.y;\n",
    "    uint listed = glbk_rsm_frame.range.y;\n",
    "    int kinds = glbk_rsm_frame.pick.w != 0u ? 4 : 3;\n",
    "    rsm_lamp l = rsm_bound();\n",
    "    vec2 turn = rsm_turn(at);\n",
    "    vec3 sum = vec3(0.0);\n",
    "    for (uint from = glbk_rsm_frame.range.x; from < listed; from += RSM_CHUNK) {\n",
    "        barrier();\n",
    "        if (from + i < listed)\n",
    "            for (int k = 0; k < kinds; k++) RSM_LIGHT(i, k) = RSM_LISTED(set * glbk_rsm_frame.range.z + from + i, k);\n",
    "        barrier();\n",
    "        if (awake) sum += rsm_listed(l, r, 0u, min(RSM_CHUNK, listed - from));\n",
    "    }\n",
    "    for (uint from = 0u; from < glbk_rsm_frame.counts.z; from += 4u * RSM_CHUNK) {\n",
    "        uint count = min(4u * RSM_CHUNK, glbk_rsm_frame.counts.z - from);\n",
    "        barrier();\n",
    "        for (uint k = i; k < count; k += RSM_CHUNK)\n",
    "            rsm_chunk[k].xyz = floatBitsToUint(RSM_PATTERN(set + (from + k) * sets));\n",
    "        barrier();\n",
    "        if (awake) sum += rsm_about(l, r, turn, 0u, 1u, count);\n",
    "    }\n",
    "    return sum / RSM_PI;\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    uint k = glbk_rsm_frame.counts.y, i = gl_LocalInvocationIndex, set = gl_WorkGroupID.z;\n",
    "    ivec2 at, size = ivec2(glbk_rsm_frame.grid.zw);\n",
    "    bool inside, first = glbk_rsm_frame.range.w == 0u;\n",
    "    vec4 sum = vec4(0.0);\n",
    "    rsm_receiver r;\n",
    "    if (glbk_rsm_frame.mode.x == 0u) {\n",
    "        at = ivec2((gl_WorkGroupID.xy * 8u + uvec2(i & 7u, i >> 3)) * k + uvec2(set % k, set / k));\n",
    "        inside = all(lessThan(at, size));\n",
    "    } else {\n",
    "        inside = rsm_item(glbk_rsm_frame.lists.x, at);\n",
    "    }\n",
    "    bool awake = rsm_read(inside ? at : ivec2(0), r) && inside;\n",
    "#if NODES\n",
    "    ivec2 number = rsm_node_number(at, int(glbk_rsm_frame.grid.y));\n",
    "    if (awake && !first) {\n",
    "        sum = imageLoad(glbk_rsm_nodes, number);\n",
    "        rsm_near = 1.0 / rsm_node_distance2(sum.w);\n",
    "    }\n",
    "#else\n",
    "    if (awake && !first) sum = imageLoad(glbk_rsm_picture, at);\n",
    "#endif\n",
    "    if (i == 0u) rsm_awake = false;\n",
    "    barrier();\n",
    "    if (awake) rsm_awake = true;\n",
    "    barrier();\n",
    "    if (rsm_awake) {\n",
    "        vec3 light = rsm_bounce_together(r, at, set, awake);\n",
    "#if NODES\n",
    "        sum = vec4(sum.xyz + light, rsm_node_alpha(1.0 / max(rsm_near, 1e-30)));\n",
    "#else\n",
    "        sum = vec4(sum.xyz + light * r.occlusion, RSM_FRESH);\n",
    "#endif\n",
    "    }\n",
    "    if (!inside || (!awake && !first)) return;\n",
    "    if (!awake) sum = vec4(0.0);\n",
    "#if NODES\n",
    "    imageStore(glbk_rsm_nodes, number, sum);\n",
    "    sum = vec4(sum.xyz * r.occlusion, RSM_EVALUATED);\n",
    "#endif\n",
    "    imageStore(glbk_rsm_picture, at, sum);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_gather_frag[] = {
    "// Bounced light, added up draw by draw. Mode 0: every pixel; 1: nodes of a grid; 2: pixels that are still open.\n",
    "// uses: rsm_bounce\n",
    "// with: screen.vert\n",
    "// sets: RSM_SURFACES=0 | RSM_SURFACES=1\n",
    "layout(location = 0) out glbk_color result;\n",
    "\n",
    "// Does an open pixel need this node? Those between it and the lines before and after it.\n",
    "bool rsm_wanted(ivec2 at, int step, ivec2 size)\n",
    "{\n",
    "    ivec2 off = at % step;\n",
    "    ivec2 from = ivec2(off.x == 0 ? max(at.x - step, 0) : at.x - off.x, off.y == 0 ? max(at.y - step, 0) : at.y - off.y);\n",
    "    ivec2 to = min(ivec2(off.x == 0 ? at.x + step - 1 : at.x, off.y == 0 ? at.y + step - 1 : at.y), size - 1);\n",
    "    for (int y = from.y; y <= to.y; y++)\n",
    "        for (int x = from.x; x <= to.x; x++)\n",
    "            if (glbk_unpack(texelFetch(glbk_rsm_states, ivec2(x, y), 0)).w == RSM_OPEN) return true;\n",
    "    return false;\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 here = ivec2(gl_FragCoord.xy), at = here, size = ivec2(glbk_rsm_frame.grid.zw), number;\n",
    "    int step = int(glbk_rsm_frame.grid.x), coarse = int(glbk_rsm_frame.grid.y), mode = int(glbk_rsm_frame.mode.x);\n",
    "    bool first = glbk_rsm_frame.range.w == 0u;\n",
    "    vec4 sum = first && mode != 2 ? vec4(0.0) : glbk_unpack(texelFetch(glbk_rsm_sum, here, 0));\n",
    "    rsm_receiver r;\n",
    "    if (mode == 1) at = min(at * step, size - 1);\n",
    "    bool seen = rsm_read(at, r), evaluate = seen;\n",
    "    if (!first) {\n",
    "        evaluate = mode == 1 ? rsm_node_fresh(sum.w) : sum.w == RSM_FRESH;\n",
    "    } else if (mode == 1 && coarse > 0) {\n",
    "        if (rsm_is_node(at, coarse, size, number)) sum = glbk_unpack(texelFetch(glbk_rsm_coarse, number, 0));\n",
    "        sum.w = rsm_node_aged(sum.w);\n",
    "        evaluate = seen && sum.w == RSM_NONE && rsm_wanted(at, step, size);\n",
    "    } else if (mode == 2) {\n",
    "        evaluate = sum.w == RSM_OPEN;\n",
    "        sum.xyz *= evaluate ? 0.0 : r.occlusion;\n",
    "    }\n",
    "    if (evaluate) {\n",
    "        if (mode == 1 && !first) rsm_near = 1.0 / rsm_node_distance2(sum.w);\n",
    "        sum.xyz += rsm_bounce(r, at) * (mode == 1 ? 1.0 : r.occlusion);\n",
    "        sum.w = mode == 1 ? rsm_node_alpha(1.0 / max(rsm_near, 1e-30)) : RSM_FRESH;\n",
    "    }\n",
    "    result = glbk_pack(sum);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_interpolate_comp[] = {
    "// rsm_interpolate.frag over every pixel (RSM_GROUP=256), then over those of a list: what the grid does for goes to the\n",
    "// picture, what stays open into the next list, the nodes of the next grid that it needs into theirs.\n",
    "// uses: rsm_lists rsm_grid\n",
    "// sets: RSM_GROUP=256 | RSM_GROUP=64\n",
    "layout(local_size_x = RSM_GROUP) in;\n",
    "\n",
    "#if RSM_GROUP == 256\n",
    "// 16 x 16 pixels have their nodes, 9 x 9 at most, in shared memory.\n",
    "const int SIDE = 9;\n",
    "shared vec4 rsm_places[SIDE * SIDE], rsm_lights[SIDE * SIDE];   // place, 1 where something is seen; light and alpha\n",
    "shared vec3 rsm_normals[SIDE * SIDE];\n",
    "\n",
    "void rsm_load_nodes(int step, int fine, ivec2 size)\n",
    "{\n",
    "    int i = int(gl_LocalInvocationIndex);\n",
    "    ivec2 node = ivec2(i % SIDE, i / SIDE);\n",
    "    if (all(lessThanEqual(node, ivec2(15 / step + 1)))) {\n",
    "        ivec2 at = min((ivec2(gl_WorkGroupID.xy * 16u) / step + node) * step, size - 1);\n",
    "        rsm_receiver r;\n",
    "        rsm_places[i].w = rsm_read(at, r) ? 1.0 : 0.0;\n",
    "        rsm_places[i].xyz = r.position;\n",
    "        rsm_normals[i] = r.normal;\n",
    "        rsm_lights[i] = texelFetch(glbk_rsm_coarse, rsm_node_number(at, fine), 0);\n",
    "    }\n",
    "    barrier();\n",
    "}\n",
    "\n",
    "bool rsm_node(ivec2 at, out rsm_receiver s, out vec4 node)\n",
    "{\n",
    "    int step = int(glbk_rsm_frame.grid.x);\n",
    "    ivec2 number = rsm_node_number(at, step) - ivec2(gl_WorkGroupID.xy * 16u) / step;\n",
    "    int i = number.y * SIDE + number.x;\n",
    "    node = rsm_lights[i];\n",
    "    s = rsm_receiver(rsm_places[i].xyz, rsm_normals[i], 1.0);\n",
    "    return rsm_places[i].w > 0.0;\n",
    "}\n",
    "#else\n",
    "bool rsm_node(ivec2 at, out rsm_receiver s, out vec4 node)\n",
    "{\n",
    "    node = texelFetch(glbk_rsm_coarse, rsm_node_number(at, int(glbk_rsm_frame.grid.y)), 0);\n",
    "    return rsm_read(at, s);\n",
    "}\n",
    "#endif\n",
    "\n",
    "void main()\n",
    "{\n",
    "    int step = int(glbk_rsm_frame.grid.x), next = int(glbk_rsm_frame.lists.w);\n",
    "    ivec2 at, size = ivec2(glbk_rsm_frame.grid.zw), number, lx, ly;\n",
    "    rsm_receiver r;\n",
    "    vec3 value;\n",
    "    float share;\n",
    "    rsm_begin_lists();\n",
    "#if RSM_GROUP == 256\n",
    "    at = ivec2(gl_WorkGroupID.xy * 16u) + ivec2(gl_LocalInvocationIndex & 15u, gl_LocalInvocationIndex >> 4);\n",
    "    bool inside = all(lessThan(at, size));\n",
    "    rsm_load_nodes(step, int(glbk_rsm_frame.grid.y), size);\n",
    "#else\n",
    "    bool inside = rsm_item(glbk_rsm_frame.lists.x, at);\n",
    "#endif\n",
    "    if (inside && !rsm_read(at, r)) {\n",
    "        imageStore(glbk_rsm_picture, at, vec4(0.0, 0.0, 0.0, RSM_NONE));\n",
    "    } else if (inside && !rsm_is_node(at, step, size, number)) {        // nodes that are in question were evaluated\n",
    "        if (rsm_interpolate(at, step, size, r, glbk_rsm_frame.tests, glbk_rsm_frame.pattern.w, value)) {\n",
    "            imageStore(glbk_rsm_picture, at, vec4(value * r.occlusion, RSM_INTERPOLATED));\n",
    "        } else {\n",
    "            rsm_add_open(at);\n",
    "            if (next > 0) {\n",
    "                rsm_grid_lines(at.x, next, size.x, lx, share);\n",
    "                rsm_grid_lines(at.y, next, size.y, ly, share);\n",
    "                for (int k = 0; k < 4; k++) rsm_want(ivec2((k & 1) != 0 ? lx.y : lx.x, (k & 2) != 0 ? ly.y : ly.x));\n",
    "            }\n",
    "        }\n",
    "    }\n",
    "    rsm_end_lists(glbk_rsm_frame.lists.y, glbk_rsm_frame.lists.z);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_interpolate_frag[] = {
    "// Pixels that the grid does for; the others stay open. The first time all are.\n",
    "// uses: rsm_grid\n",
    "// with: screen.vert\n",
    "layout(location = 0) out glbk_color result;\n",
    "\n",
    "bool rsm_node(ivec2 at, out rsm_receiver s, out vec4 node)\n",
    "{\n",
    "    node = glbk_unpack(texelFetch(glbk_rsm_coarse, rsm_node_number(at, int(glbk_rsm_frame.grid.x)), 0));\n",
    "    return rsm_read(at, s);\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy), size = ivec2(glbk_rsm_frame.grid.zw), number;\n",
    "    int step = int(glbk_rsm_frame.grid.x);\n",
    "    vec4 sum = vec4(0.0, 0.0, 0.0, RSM_OPEN);\n",
    "    rsm_receiver r;\n",
    "    bool seen = rsm_read(at, r);\n",
    "    if (glbk_rsm_frame.range.w != 0u) sum = glbk_unpack(texelFetch(glbk_rsm_sum, at, 0));\n",
    "    else if (!seen) sum.w = RSM_NONE;\n",
    "    if (seen && rsm_is_node(at, step, size, number)) {      // what was evaluated replaces what was interpolated\n",
    "        vec4 node = glbk_unpack(texelFetch(glbk_rsm_coarse, number, 0));\n",
    "        if (node.w < 0.0) sum = vec4(node.xyz, RSM_EVALUATED);\n",
    "    }\n",
    "    vec3 value;\n",
    "    if (sum.w == RSM_OPEN && rsm_interpolate(at, step, size, r, glbk_rsm_frame.tests, glbk_rsm_frame.pattern.w, value))\n",
    "        sum = vec4(value, RSM_INTERPOLATED);\n",
    "    result = glbk_pack(sum);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_pick_frag[] = {
    "// Pixel lights of one map into the list. ALL=1: every texel in turn, else in proportion to flux.\n",
    "// uses: rsm_gather\n",
    "// with: screen.vert\n",
    "// sets: ALL=0 | ALL=1\n",
    "#ifndef ALL\n",
    "#define ALL 0\n",
    "#endif\n",
    "layout(location = 0) out uvec4 rsm_out_place;\n",
    "layout(location = 1) out uvec4 rsm_out_normal;\n",
    "layout(location = 2) out uvec4 rsm_out_flux;\n",
    "layout(location = 3) out uvec4 rsm_out_gloss;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    uint e = uint(gl_FragCoord.y) * 1024u + uint(gl_FragCoord.x), k = glbk_rsm_frame.counts.y, sets = k * k;\n",
    "    uint at = e % glbk_rsm_frame.range.z, seed = glbk_rsm_frame.pick.x, n = glbk_rsm_frame.pick.y;\n",
    "    uint set = e / glbk_rsm_frame.range.z;\n",
    "    if (set >= sets || at < glbk_rsm_frame.range.x || at >= glbk_rsm_frame.range.y) discard;\n",
    "    // Runs of neighbours go to all sets, each run in another order.\n",
    "    uint run = glbk_rsm_frame.pick.z + at - glbk_rsm_frame.range.x;\n",
    "    uint i = run * sets + (set + sets - rsm_hash_combine(seed, run) % sets) % sets;\n",
    "    rsm_lamp l = rsm_bound();\n",
    "    ivec3 t = ivec3(0);\n",
    "    float weight = 1.0;\n",
    "    bool lit = i < n;\n",
    "#if ALL\n",
    "    uint size = uint(l.size);\n",
    "    if (lit) t = ivec3(i % size, i / size % size, i / (size * size));\n",
    "#else\n",
    "    if (lit) lit = rsm_pick_texel(l, i, n, seed, t, weight);\n",
    "#endif\n",
    "    vec4 flux = uintBitsToFloat(RSM_TEXEL(t, 2)), place = uintBitsToFloat(RSM_TEXEL(t, 0));\n",
    "    uvec4 normal = RSM_TEXEL(t, 1);\n",
    "    vec4 limits = glbk_rsm_frame.limits;\n",
    "    bool glossy = normal.w != 0u && normal.w <= glbk_rsm_frame.pick.w;      // black ones shine too\n",
    "    lit = lit && (rsm_mean3(flux.xyz) > 0.0 || glossy);\n",
    "    if (!lit) normal = uvec4(0u);           // faces nobody: is no receiver's nearest light\n",
    "    float scale = lit ? weight * limits.w : 0.0;\n",
    "    place.xyz -= limits.x * uintBitsToFloat(normal.xyz);\n",
    "    place.w = rsm_bound_of(flux.w * weight, limits.y, limits.z);\n",
    "    rsm_out_place = floatBitsToUint(place);\n",
    "#if ALL\n",
    "    float field = glbk_rsm_frame.surfaces.x, last = field * field * flux.w;\n",
    "#else\n",
    "    float last = lit && glbk_rsm_frame.pattern.z > 0.0 ? 1.0 / weight : 0.0;\n",
    "#endif\n",
    "    rsm_out_normal = uvec4(normal.xyz, floatBitsToUint(last));\n",
    "    rsm_out_flux = uvec4(floatBitsToUint(flux.xyz * scale), uint(t.x) | uint(t.y) << 12 | uint(t.z) << 24);\n",
    "    rsm_out_gloss = uvec4(0u);\n",
    "    if (lit && glossy)\n",
    "        rsm_out_gloss = uvec4(floatBitsToUint(rsm_incident(l, t.z, t.xy) * l.value * scale), normal.w);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_recall_frag[] = {
    "// This frame's light and what the last frames knew of the same surface; alpha: frames.\n",
    "// uses: rsm_screen\n",
    "// with: screen.vert\n",
    "layout(location = 0) out glbk_color result;\n",
    "\n",
    "// Where the surface was in the last frame, in pixels.\n",
    "bool rsm_reproject(ivec2 at, vec3 p, vec2 size, out vec2 q)\n",
    "{\n",
    "    q = vec2(0.0);\n",
    "    if (glbk_rsm_frame.mode.y == 2u) {\n",
    "        q = texelFetch(glbk_rsm_motion, at, 0).xy;\n",
    "    } else if (glbk_rsm_frame.mode.y == 1u) {\n",
    "        vec4 c = glbk_rsm_drawn.clip * vec4(p, 1.0);\n",
    "        if (!(c.w > 0.0)) return false;\n",
    "        q = (vec2(c.x, glbk_rsm_frame.mode.z != 0u ? -c.y : c.y) / c.w * 0.5 + 0.5) * size;\n",
    "    } else {\n",
    "        return false;\n",
    "    }\n",
    "    return all(lessThan(abs(q), vec2(1e6)));        // false for what is not a number\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy), size = ivec2(glbk_rsm_frame.grid.zw);\n",
    "    float most = glbk_rsm_frame.pattern.w;\n",
    "    vec4 now = glbk_unpack(texelFetch(glbk_rsm_sum, at, 0));\n",
    "    bool moved = glbk_rsm_frame.mode.y == 2u;\n",
    "    vec2 q;\n",
    "    rsm_receiver r, s;\n",
    "    if (!rsm_read(at, r)) {\n",
    "        result = glbk_pack(vec4(0.0));\n",
    "        return;\n",
    "    }\n",
    "    now.w = 1.0;\n",
    "    if (most > 1.0 && rsm_reproject(at, r.position, vec2(size), q)) {\n",
    "        // Within four of this frame's pixels the last frame may show this point.\n",
    "        ivec2 other = ivec2(at.x + 1 < size.x ? at.x + 1 : max(at.x - 1, 0), at.y);\n",
    "        vec3 d = uintBitsToFloat(RSM_SEEN(other, 0).xyz) - r.position;\n",
    "        float reach = dot(d, d) < 1e18 ? 16.0 * dot(d, d) + 1e-12 : 1e-12, total = 0.0;\n",
    "        vec2 centre = floor(q), place = mix(q - 0.5, centre, lessThan(abs(q - 0.5 - centre), vec2(1.0 / 64.0)));\n",
    "        vec2 from = floor(place), f = place - from;         // a still camera finds one pixel, not four of rounding\n",
    "        vec4 old = vec4(0.0);\n",
    "        for (int k = 0; k < 4; k++) {\n",
    "            ivec2 there = ivec2(from) + ivec2(k & 1, k >> 1);\n",
    "            float weight = ((k & 1) != 0 ? f.x : 1.0 - f.x) * ((k & 2) != 0 ? f.y : 1.0 - f.y);\n",
    "            if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, size))) continue;\n",
    "            vec4 history = glbk_unpack(texelFetch(glbk_rsm_history, there, 0));\n",
    "            if (!(history.w > 0.0)) continue;\n",
    "            s.position = uintBitsToFloat(texelFetch(glbk_rsm_before, ivec3(there, 0), 0).xyz);\n",
    "            s.normal = uintBitsToFloat(texelFetch(glbk_rsm_before, ivec3(there, 1), 0).xyz);\n",
    "            d = s.position - r.position;\n",
    "            if (!moved && dot(d, d) > reach) continue;      // moved surfaces are found by motion only\n",
    "            weight *= moved ? (dot(r.normal, s.normal) > 0.5 ? 1.0 : 0.0)\n",
    "                            : rsm_alike(r.position, r.normal, s.position, s.normal, glbk_rsm_frame.tests.x,\n",
    "                                        glbk_rsm_frame.tests.y);\n",
    "            total += weight;\n",
    "            old += weight * history;\n",
    "        }\n",
    "        if (total > 0.01) {\n",
    "            old /= total;\n",
    "            now.w = min(old.w + 1.0, most);\n",
    "            now.xyz = mix(old.xyz, now.xyz, 1.0 / now.w);\n",
    "        }\n",
    "    }\n",
    "    result = glbk_pack(now);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_resolve_frag[] = {
    "// Radiance: albedo / pi times direct and bounced light.\n",
    "// uses: rsm_access\n",
    "// with: screen.vert\n",
    "layout(location = 0) out vec4 result;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy) - ivec2(glbk_rsm_frame.range.xy);\n",
    "    vec3 light = vec3(0.0), albedo = uintBitsToFloat(RSM_SEEN(at, 2).xyz);\n",
    "    if (glbk_rsm_frame.mode.x != 0u) light += glbk_unpack(texelFetch(glbk_rsm_sum, at, 0)).xyz;\n",
    "    if (glbk_rsm_frame.mode.y != 0u) light += glbk_unpack(texelFetch(glbk_rsm_states, at, 0)).xyz;\n",
    "    result = vec4(albedo * light / RSM_PI, 1.0);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_scan_comp[] = {
    "// Running sums of the rows of a map, or (ROWS=1) of its rows' last ones: a group has a row in shared memory. The steps\n",
    "// are rsm_scan.frag's, of eight values each, so that both ways pick the same texels; the mean's third is multiplied\n",
    "// where it is there, too, since compilers make one operation of it and the sum.\n",
    "// uses: rsm_pick\n",
    "// sets: ROWS=0 | ROWS=1\n",
    "#ifndef ROWS\n",
    "#define ROWS 0\n",
    "#endif\n",
    "layout(local_size_x = 256) in;\n",
    "shared float rsm_row[2][4096];\n",
    "\n",
    "void main()\n",
    "{\n",
    "    int size = int(glbk_rsm_light.value.w), now = 0;\n",
    "    ivec3 at = ivec3(gl_LocalInvocationIndex, gl_WorkGroupID.xy);\n",
    "    for (int x = at.x; x < size; x += 256)\n",
    "#if ROWS\n",
    "        rsm_row[0][x] = RSM_ROW_SUM(ivec3(size - 1, x, at.z));\n",
    "#else\n",
    "    {\n",
    "        vec3 flux = uintBitsToFloat(RSM_TEXEL(ivec3(x, at.yz), 2).xyz);\n",
    "        rsm_row[0][x] = flux.x + flux.y + flux.z;\n",
    "    }\n",
    "#endif\n",
    "    float scale = ROWS == 0 ? 1.0 / 3.0 : 1.0;\n",
    "    for (int stride = 1; stride < size; stride *= 8, now = 1 - now) {\n",
    "        barrier();\n",
    "        for (int x = at.x; x < size; x += 256) {\n",
    "            float sum = 0.0;\n",
    "            for (int k = 0; k < 8 && x - k * stride >= 0; k++) sum += rsm_row[now][x - k * stride] * scale;\n",
    "            rsm_row[1 - now][x] = sum;\n",
    "        }\n",
    "        scale = 1.0;\n",
    "    }\n",
    "    for (int x = at.x; x < size; x += 256)          // what this invocation wrote itself\n",
    "        imageStore(glbk_rsm_running, ivec3(x, at.yz), uvec4(floatBitsToUint(rsm_row[now][x])));\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_scan_frag[] = {
    "// One step of running sums along x: 8 values, `stride` apart. FROM 0: mean flux of the map; 1: sums of the step before; 2: the\n",
    "// last sums of rows, and 3 sums of these.\n",
    "// uses: rsm_pick\n",
    "// with: screen.vert\n",
    "// sets: FROM=0 | FROM=1 | FROM=2 | FROM=3\n",
    "#ifndef FROM\n",
    "#define FROM 0\n",
    "#endif\n",
    "layout(location = 0) out uint result;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec3 at = ivec3(ivec2(gl_FragCoord.xy), int(glbk_rsm_frame.pick.x));\n",
    "    int stride = int(glbk_rsm_frame.pick.y);\n",
    "    float sum = 0.0;\n",
    "    for (int k = 0; k < 8 && at.x >= 0; k++, at.x -= stride) {\n",
    "#if FROM == 0\n",
    "        sum += rsm_mean3(uintBitsToFloat(RSM_TEXEL(at, 2).xyz));\n",
    "#elif FROM == 1\n",
    "        sum += RSM_ROW_SUM(at);\n",
    "#elif FROM == 2\n",
    "        sum += RSM_ROW_SUM(ivec3(textureSize(glbk_rsm_sums, 0).x - 1, at.x, at.z));\n",
    "#else\n",
    "        sum += RSM_ROWS_SUM(at.x, at.z);\n",
    "#endif\n",
    "    }\n",
    "    result = floatBitsToUint(sum);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_smooth_comp[] = {
    "// rsm_smooth.frag as a compute shader: 16 x 16 pixels, `step` apart, and those round them through shared memory, so\n",
    "// that a pixel is fetched 1.27 times, not nine. The groups of one part of the picture are step x step layers.\n",
    "// uses: rsm_smooth\n",
    "layout(local_size_x = 16, local_size_y = 16) in;\n",
    "const int SIDE = 18;\n",
    "shared vec4 rsm_places[SIDE * SIDE], rsm_lights[SIDE * SIDE];   // place, 1 where something is seen; light and alpha\n",
    "shared vec3 rsm_normals[SIDE * SIDE];\n",
    "\n",
    "int rsm_here(ivec2 off)\n",
    "{\n",
    "    ivec2 at = ivec2(gl_LocalInvocationID.xy) + 1 + off;\n",
    "    return at.y * SIDE + at.x;\n",
    "}\n",
    "\n",
    "bool rsm_neighbour(ivec2 at, ivec2 off, out rsm_receiver s, out vec3 light)\n",
    "{\n",
    "    int i = rsm_here(off);\n",
    "    s = rsm_receiver(rsm_places[i].xyz, rsm_normals[i], 1.0);\n",
    "    light = rsm_lights[i].xyz;\n",
    "    return rsm_places[i].w > 0.0;\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    int step = int(glbk_rsm_frame.grid.x), layer = int(gl_WorkGroupID.z);\n",
    "    ivec2 size = ivec2(glbk_rsm_frame.grid.zw), tile = ivec2(gl_WorkGroupID.xy) * 16;\n",
    "    ivec2 from = ivec2(layer % step, layer / step);\n",
    "    ivec2 at = (tile + ivec2(gl_LocalInvocationID.xy)) * step + from;\n",
    "    for (int i = int(gl_LocalInvocationIndex); i < SIDE * SIDE; i += 256) {\n",
    "        ivec2 there = (tile + ivec2(i % SIDE, i / SIDE) - 1) * step + from;\n",
    "        rsm_receiver r = rsm_receiver(vec3(0.0), vec3(0.0), 0.0);\n",
    "        bool seen = all(greaterThanEqual(there, ivec2(0))) && all(lessThan(there, size));\n",
    "        if (seen) seen = rsm_read(there, r);\n",
    "        rsm_places[i] = vec4(r.position, seen ? 1.0 : 0.0);\n",
    "        rsm_normals[i] = r.normal;\n",
    "        rsm_lights[i] = seen ? texelFetch(glbk_rsm_sum, there, 0) : vec4(0.0);\n",
    "    }\n",
    "    barrier();\n",
    "    if (any(greaterThanEqual(at, size))) return;\n",
    "    int here = rsm_here(ivec2(0));\n",
    "    rsm_receiver r = rsm_receiver(rsm_places[here].xyz, rsm_normals[here], 1.0);\n",
    "    vec4 sum = vec4(0.0);\n",
    "    if (rsm_places[here].w > 0.0) sum = rsm_smooth(at, r, rsm_lights[here]);\n",
    "    imageStore(glbk_rsm_picture, at, sum);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_rsm_smooth_frag[] = {
    "// One pass of the a-trous filter.\n",
    "// uses: rsm_smooth\n",
    "// with: screen.vert\n",
    "layout(location = 0) out glbk_color result;\n",
    "\n",
    "bool rsm_neighbour(ivec2 at, ivec2 off, out rsm_receiver s, out vec3 light)\n",
    "{\n",
    "    ivec2 there = at + off * int(glbk_rsm_frame.grid.x), size = ivec2(glbk_rsm_frame.grid.zw);\n",
    "    bool inside = all(greaterThanEqual(there, ivec2(0))) && all(lessThan(there, size));\n",
    "    light = vec3(0.0);\n",
    "    if (!inside || !rsm_read(there, s)) return false;\n",
    "    light = glbk_unpack(texelFetch(glbk_rsm_sum, there, 0)).xyz;\n",
    "    return true;\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n",
    "    rsm_receiver r;\n",
    "    vec4 sum = vec4(0.0);\n",
    "    if (rsm_read(at, r)) sum = rsm_smooth(at, r, glbk_unpack(texelFetch(glbk_rsm_sum, at, 0)));\n",
    "    result = glbk_pack(sum);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_screen_vert[] = {
    "// A triangle over the whole viewport, from no attributes at all: vertices (-1, -1), (3, -1), (-1, 3).\n",
    "void main()\n",
    "{\n",
    "    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_sfield_gbuffer_frag[] = {
    "// One object into the G-buffer; at most 4 bands of own visibility, interpolated between the vertices.\n",
    "// uses: sfield_bindings\n",
    "// with: sfield_gbuffer.vert\n",
    "in vec3 sfield_place_at, sfield_facing;\n",
    "in vec4 sfield_self0, sfield_self1, sfield_self2, sfield_self3;\n",
    "layout(location = 0) out uvec4 sfield_out_place;\n",
    "layout(location = 1) out uvec4 sfield_out_normal;\n",
    "layout(location = 2) out uvec4 sfield_out_self0;\n",
    "layout(location = 3) out uvec4 sfield_out_self1;\n",
    "\n",
    "uvec2 sfield_halves(vec4 v)\n",
    "{\n",
    "    ivec4 q = ivec4(floor(clamp(v * (1.0 / 1.5), -1.0, 1.0) * 32767.0 + 0.5));\n",
    "    uvec4 u = uvec4(q) & 0xffffu;\n",
    "    return u.xz | (u.yw << 16);\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    uvec4 kinds = glbk_sfield_object.kinds;     // entity, 1 where attributes 2 to 5 are there\n",
    "    float exponent = glbk_sfield_object.gloss.x;\n",
    "    vec3 n = sfield_facing * inversesqrt(max(dot(sfield_facing, sfield_facing), 1e-30));\n",
    "    sfield_out_place = uvec4(floatBitsToUint(sfield_place_at), kinds.x);\n",
    "    sfield_out_normal = uvec4(floatBitsToUint(n), floatBitsToUint(exponent) | (kinds.y << 31));\n",
    "    sfield_out_self0 = uvec4(sfield_halves(sfield_self0), sfield_halves(sfield_self1));\n",
    "    sfield_out_self1 = uvec4(sfield_halves(sfield_self2), sfield_halves(sfield_self3));\n",
    "}\n"
};

static const char *const glbk__glsl_prog_sfield_gbuffer_vert[] = {
    "// Attributes 0 position, 1 normal, 2 to 5 the coefficients of own visibility x cosine at the vertex.\n",
    "// uses: sfield_bindings\n",
    "layout(location = 0) in vec3 position;\n",
    "layout(location = 1) in vec3 normal;\n",
    "layout(location = 2) in vec4 self0;\n",
    "layout(location = 3) in vec4 self1;\n",
    "layout(location = 4) in vec4 self2;\n",
    "layout(location = 5) in vec4 self3;\n",
    "out vec3 sfield_place_at, sfield_facing;\n",
    "out vec4 sfield_self0, sfield_self1, sfield_self2, sfield_self3;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    mat3 m = mat3(glbk_sfield_object.world);\n",
    "    sfield_place_at = (glbk_sfield_object.world * vec4(position, 1.0)).xyz;\n",
    "    sfield_facing = m * normal;                 // entities scale evenly\n",
    "    sfield_self0 = self0;\n",
    "    sfield_self1 = self1;\n",
    "    sfield_self2 = self2;\n",
    "    sfield_self3 = self3;\n",
    "    gl_Position = glbk_sfield_object.clip * vec4(sfield_place_at, 1.0);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_sfield_project_comp[] = {
    "// sfield_project.frag as a compute shader: a work group is an eye and channel. Each invocation projects its share of\n",
    "// the texels on all harmonics, in registers; then the shares are added.\n",
    "// uses: table sfield_bindings\n",
    "// sets: SFIELD_SOURCE=0 SFIELD_BANDS=4 | SFIELD_SOURCE=1 SFIELD_BANDS=8\n",
    "#ifndef SFIELD_BANDS\n",
    "#define SFIELD_BANDS 4\n",
    "#endif\n",
    "#define SFIELD_GROUPS ((SFIELD_BANDS * SFIELD_BANDS + 3) / 4)\n",
    "layout(local_size_x = 64) in;\n",
    "shared vec4 sfield_shares[64 * SFIELD_GROUPS];\n",
    "\n",
    "vec4 sfield_basis_at(uint i) { return uintBitsToFloat(texelFetch(glbk_sfield_basis, glbk_table_at(i), 0)); }\n",
    "\n",
    "void main()\n",
    "{\n",
    "    uint eye = gl_WorkGroupID.x, channel = gl_WorkGroupID.y, side = glbk_sfield_views.how.w, cells = 6u * side * side;\n",
    "    uint me = gl_LocalInvocationID.x;\n",
    "    vec4 sum[SFIELD_GROUPS];\n",
    "    for (int g = 0; g < SFIELD_GROUPS; g++) sum[g] = vec4(0.0);\n",
    "    for (uint cell = me; cell < cells; cell += 64u) {\n",
    "        uint x = cell % (6u * side), y = eye * side + cell / (6u * side);\n",
    "#if SFIELD_SOURCE\n",
    "        float a = uintBitsToFloat(texelFetch(glbk_sfield_cube, ivec2(x, y), 0)[channel]);\n",
    "#else\n",
    "        float a = uintBitsToFloat(texelFetch(glbk_sfield_cube, ivec2(x / 4u, y), 0)[x & 3u]);\n",
    "#endif\n",
    "        if (a != 0.0)\n",
    "            for (int g = 0; g < SFIELD_GROUPS; g++) sum[g] += a * sfield_basis_at(uint(g) * cells + cell);\n",
    "    }\n",
    "    for (int g = 0; g < SFIELD_GROUPS; g++) sfield_shares[me * uint(SFIELD_GROUPS) + uint(g)] = sum[g];\n",
    "    memoryBarrierShared();\n",
    "    barrier();\n",
    "    if (me >= uint(SFIELD_GROUPS)) return;\n",
    "    vec4 all = vec4(0.0);\n",
    "    for (uint i = 0u; i < 64u; i++) all += sfield_shares[i * uint(SFIELD_GROUPS) + me];\n",
    "    imageStore(glbk_sfield_coefs_image, ivec2(channel * uint(SFIELD_GROUPS) + me, eye), floatBitsToUint(all));\n",
    "}\n"
};

static const char *const glbk__glsl_prog_sfield_project_frag[] = {
    "// Four coefficients of a cube: texels times what the basis integrates to over each. A column is a group of four,\n",
    "// after all groups of one channel those of the next; a row is an eye. Twin: sfield_sh_project.\n",
    "// uses: table sfield_bindings\n",
    "// with: screen.vert\n",
    "// sets: SFIELD_SOURCE=0 | SFIELD_SOURCE=1\n",
    "layout(location = 0) out uvec4 coefs;\n",
    "\n",
    "vec4 sfield_basis_at(uint i) { return uintBitsToFloat(texelFetch(glbk_sfield_basis, glbk_table_at(i), 0)); }\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n",
    "    int side = int(glbk_sfield_views.how.w);\n",
    "    uint group = uint(at.x) % glbk_sfield_views.size.y, channel = uint(at.x) / glbk_sfield_views.size.y;\n",
    "    uint cell = group * uint(6 * side * side);\n",
    "    vec4 sum = vec4(0.0);\n",
    "#if SFIELD_SOURCE\n",
    "    int width = 6 * side;\n",
    "#else\n",
    "    int width = 6 * side / 4;\n",
    "#endif\n",
    "    for (int y = 0; y < side; y++)\n",
    "        for (int x = 0; x < width; x++) {\n",
    "            vec4 v = uintBitsToFloat(texelFetch(glbk_sfield_cube, ivec2(x, at.y * side + y), 0));\n",
    "#if SFIELD_SOURCE\n",
    "            float a = channel == 0u ? v.x : channel == 1u ? v.y : v.z;\n",
    "            if (a != 0.0) sum += a * sfield_basis_at(cell);\n",
    "            cell++;\n",
    "#else\n",
    "            if (v != vec4(0.0)) {\n",
    "                sum += v.x * sfield_basis_at(cell);\n",
    "                sum += v.y * sfield_basis_at(cell + 1u);\n",
    "                sum += v.z * sfield_basis_at(cell + 2u);\n",
    "                sum += v.w * sfield_basis_at(cell + 3u);\n",
    "            }\n",
    "            cell += 4u;\n",
    "#endif\n",
    "        }\n",
    "    coefs = floatBitsToUint(sum);\n",
    "}\n"
};

static const char *const glbk__glsl_prog_sfield_see_frag[] = {
    "// What is seen: 1 where anything hides, or the radiance of the nearest triangle, which it emits on one side.\n",
    "// uses: sfield_bindings\n",
    "// with: sfield_see.vert\n",
    "// sets: SFIELD_SOURCE=0 | SFIELD_SOURCE=1\n",
    "#if SFIELD_SOURCE\n",
    "flat in vec3 sfield_radiance;\n",
    "in float sfield_depth;\n",
    "#endif\n",
    "layout(location = 0) out uvec4 seen;\n",
    "\n",
    "void main()\n",
    "{\n",
    "#if SFIELD_SOURCE\n",
    "    seen = uvec4(floatBitsToUint(gl_FrontFacing ? sfield_radiance : vec3(0.0)), 0u);\n",
    "    gl_FragDepth = clamp(gl_FrontFacing ? sfield_depth : 1.0001 * sfield_depth, 0.0, 1.0);   // for sheets that shine twice\n",
    "#else\n",
    "    seen = uvec4(1u);\n",
    "#endif\n",
    "}\n"
};

static const char *const glbk__glsl_prog_sfield_see_vert[] = {
    "// A mesh as seen from the eyes of a column of tiles, one tile an instance. The viewport is the column and clips along\n",
    "// x; the near and far planes stand in along y, so that no triangle leaves its tile. Attribute 0 is the position, 1 the\n",
    "// radiance.\n",
    "// uses: sfield_bindings\n",
    "// sets: SFIELD_SOURCE=0 | SFIELD_SOURCE=1\n",
    "layout(location = 0) in vec3 position;\n",
    "#if SFIELD_SOURCE\n",
    "layout(location = 1) in vec3 radiance;\n",
    "flat out vec3 sfield_radiance;\n",
    "out float sfield_depth;\n",
    "#endif\n",
    "\n",
    "// Along s, t and the axis of a face, as sfield_cube_texel has them.\n",
    "vec3 sfield_to_face(uint face, vec3 p)\n",
    "{\n",
    "    if (face == 0u) return vec3(-p.z, -p.y, p.x);\n",
    "    if (face == 1u) return vec3(p.z, -p.y, -p.x);\n",
    "    if (face == 2u) return vec3(p.x, p.z, p.y);\n",
    "    if (face == 3u) return vec3(p.x, -p.z, -p.y);\n",
    "    return face == 4u ? vec3(p.x, -p.y, p.z) : vec3(-p.x, -p.y, -p.z);\n",
    "}\n",
    "\n",
    "void main()\n",
    "{\n",
    "    uint tile = glbk_sfield_views.how.x + uint(gl_InstanceID);\n",
    "    vec4 eye = glbk_sfield_views.eyes[tile];\n",
    "    uvec4 place = glbk_sfield_views.places[tile];\n",
    "    vec4 sphere = glbk_sfield_views.sphere;\n",
    "    vec3 q = sfield_to_face(place.x, (position - sphere.xyz) / sphere.w - eye.xyz);\n",
    "    float rows = float(glbk_sfield_views.how.y);\n",
    "    gl_Position = vec4(q.x, (q.y + (float(2u * place.w) + 1.0) * q.z) / rows - q.z, q.y, q.z);\n",
    "#if SFIELD_SOURCE\n",
    "    sfield_radiance = radiance;\n",
    "    sfield_depth = q.z * eye.w;\n",
    "#endif\n",
    "}\n"
};

static const char *const glbk__glsl_prog_sfield_shade_comp[] = {
    "// sfield_shade.frag as a compute shader: the entities near its 8 x 8 pixels are found by a work group together.\n",
    "// uses: sfield_list sfield_gbuffer\n",
    "// sets: SFIELD_BANDS=4 SFIELD_GLOSS=0 | SFIELD_BANDS=3 SFIELD_GLOSS=1 | SFIELD_BANDS=8 SFIELD_GLOSS=0\n",
    "layout(local_size_x = 8, local_size_y = 8) in;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_GlobalInvocationID.xy);\n",
    "    bool inside = all(lessThan(at, textureSize(glbk_sfield_place, 0)));\n",
    "    sfield_point p = sfield_point(vec3(0.0), vec3(0.0), SFIELD_NONE, 0.0, false);\n",
    "    sfield_sums sums = sfield_sums(vec3(0.0), vec3(0.0), 0.0);\n",
    "    bool seen = inside && sfield_read_point(at, p);\n",
    "    sfield_list(p.position, p.normal, seen);\n",
    "    if (seen) sums = sfield_shade_point(at, p);\n",
    "    if (!inside) return;\n",
    "    imageStore(glbk_sfield_light_image, at, vec4(sums.light, sums.open));\n",
    "#if SFIELD_GLOSS\n",
    "    imageStore(glbk_sfield_gloss_image, at, vec4(sums.gloss, 1.0));\n",
    "#endif\n",
    "}\n"
};

static const char *const glbk__glsl_prog_sfield_shade_frag[] = {
    "// Light at each pixel of the G-buffer: rgb without albedo, and the share of the cosine-weighted sky that is open.\n",
    "// uses: sfield_gbuffer\n",
    "// with: screen.vert\n",
    "// sets: SFIELD_BANDS=4 SFIELD_GLOSS=0 | SFIELD_BANDS=3 SFIELD_GLOSS=1 | SFIELD_BANDS=8 SFIELD_GLOSS=0\n",
    "layout(location = 0) out glbk_color light;\n",
    "#if SFIELD_GLOSS\n",
    "layout(location = 1) out glbk_color gloss;\n",
    "#endif\n",
    "\n",
    "void main()\n",
    "{\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n",
    "    sfield_point p;\n",
    "    sfield_sums sums = sfield_sums(vec3(0.0), vec3(0.0), 0.0);\n",
    "    if (sfield_read_point(at, p)) sums = sfield_shade_point(at, p);\n",
    "    light = glbk_pack(vec4(sums.light, sums.open));\n",
    "#if SFIELD_GLOSS\n",
    "    gloss = glbk_pack(vec4(sums.gloss, 1.0));\n",
    "#endif\n",
    "}\n"
};

static const char *const glbk__glsl_prog_sfield_sum_comp[] = {
    "// sfield_sum.frag as a compute shader: a work group counts the samples of a row of texels of a tile. Each invocation\n",
    "// adds up columns, neighbours side by side (alpha: two columns, by gathers of 2 x 2), then texels are made of columns.\n",
    "// uses: sfield_bindings\n",
    "// sets: SFIELD_SOURCE=0 | SFIELD_SOURCE=1\n",
    "layout(local_size_x = 32) in;\n",
    "#if SFIELD_SOURCE\n",
    "shared vec3 sfield_columns[256];\n",
    "#else\n",
    "shared uint sfield_columns[256];\n",
    "#endif\n",
    "\n",
    "void main()\n",
    "{\n",
    "    uvec4 place = glbk_sfield_views.places[gl_WorkGroupID.y];\n",
    "    uint width = glbk_sfield_views.how.z, side = glbk_sfield_views.how.w, scale = width / side;\n",
    "    uint me = gl_LocalInvocationID.x;\n",
    "    ivec2 from = ivec2(place.zw * width + uvec2(0u, gl_WorkGroupID.x * scale));\n",
    "    ivec2 to = ivec2(place.x * side, place.y * side + gl_WorkGroupID.x);\n",
    "    float share = 1.0 / float(scale * scale);\n",
    "#if SFIELD_SOURCE\n",
    "    for (uint x = me; x < width; x += 32u) {\n",
    "        vec3 sum = vec3(0.0);\n",
    "        for (uint y = 0u; y < scale; y++)\n",
    "            sum += uintBitsToFloat(texelFetch(glbk_sfield_seen, from + ivec2(x, y), 0).xyz);\n",
    "        sfield_columns[x] = sum;\n",
    "    }\n",
    "    memoryBarrierShared();\n",
    "    barrier();\n",
    "    for (uint x = me; x < side; x += 32u) {\n",
    "        vec3 sum = vec3(0.0);\n",
    "        for (uint k = 0u; k < scale; k++) sum += sfield_columns[x * scale + k];\n",
    "        imageStore(glbk_sfield_cube_image, to + ivec2(x, 0), uvec4(floatBitsToUint(sum * share), 0u));\n",
    "    }\n",
    "#else\n",
    "    vec2 unit = 1.0 / vec2(textureSize(glbk_sfield_seen, 0));\n",
    "    for (uint x = me; x < width / 2u; x += 32u) {\n",
    "        uvec4 sum = uvec4(0u);\n",
    "        for (uint y = 0u; y < scale; y += 2u)\n",
    "            sum += textureGather(glbk_sfield_seen, vec2(from + ivec2(2u * x + 1u, y + 1u)) * unit);\n",
    "        sfield_columns[x] = sum.x + sum.y + sum.z + sum.w;\n",
    "    }\n",
    "    memoryBarrierShared();\n",
    "    barrier();\n",
    "    for (uint x = me; x < side / 4u; x += 32u) {\n",
    "        uvec4 sum = uvec4(0u);\n",
    "        for (uint k = 0u; k < scale / 2u; k++)\n",
    "            for (uint i = 0u; i < 4u; i++) sum[i] += sfield_columns[(4u * x + i) * (scale / 2u) + k];\n",
    "        imageStore(glbk_sfield_cube_image, ivec2(place.x * side / 4u + x, to.y), floatBitsToUint(vec4(sum) * share));\n",
    "    }\n",
    "#endif\n",
    "}\n"
};

static const char *const glbk__glsl_prog_sfield_sum_frag[] = {
    "// Samples counted into texels: four neighbours' alpha, or a texel's radiance.\n",
    "// uses: sfield_bindings\n",
    "// with: sfield_sum.vert\n",
    "// sets: SFIELD_SOURCE=0 | SFIELD_SOURCE=1\n",
    "flat in uint sfield_tile;\n",
    "layout(location = 0) out uvec4 texels;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    uvec4 place = glbk_sfield_views.places[sfield_tile];\n",
    "    int width = int(glbk_sfield_views.how.z), side = int(glbk_sfield_views.how.w), scale = width / side;\n",
    "    ivec2 at = ivec2(gl_FragCoord.xy), tile = ivec2(place.zw) * width;\n",
    "    float share = 1.0 / float(scale * scale);\n",
    "#if SFIELD_SOURCE\n",
    "    ivec2 from = tile + (at - ivec2(place.xy) * side) * scale;\n",
    "    vec3 sum = vec3(0.0);\n",
    "    for (int y = 0; y < scale; y++)\n",
    "        for (int x = 0; x < scale; x++)\n",
    "            sum += uintBitsToFloat(texelFetch(glbk_sfield_seen, from + ivec2(x, y), 0).xyz);\n",
    "    texels = uvec4(floatBitsToUint(sum * share), 0u);\n",
    "#else\n",
    "    ivec2 from = tile + (at - ivec2(int(place.x) * side / 4, int(place.y) * side)) * ivec2(4 * scale, scale);\n",
    "    uvec4 sum = uvec4(0u);\n",
    "    for (int y = 0; y < scale; y++)\n",
    "        for (int x = 0; x < scale; x++) {\n",
    "            ivec2 p = from + ivec2(x, y), next = ivec2(scale, 0);\n",
    "            sum.x += texelFetch(glbk_sfield_seen, p, 0).x;\n",
    "            sum.y += texelFetch(glbk_sfield_seen, p + next, 0).x;\n",
    "            sum.z += texelFetch(glbk_sfield_seen, p + 2 * next, 0).x;\n",
    "            sum.w += texelFetch(glbk_sfield_seen, p + 3 * next, 0).x;\n",
    "        }\n",
    "    texels = floatBitsToUint(vec4(sum) * share);\n",
    "#endif\n",
    "}\n"
};

static const char *const glbk__glsl_prog_sfield_sum_vert[] = {
    "// The texels of a tile, an instance each: a strip of four vertices over one face of one eye's cube.\n",
    "// uses: sfield_bindings\n",
    "// sets: SFIELD_SOURCE=0 | SFIELD_SOURCE=1\n",
    "flat out uint sfield_tile;\n",
    "\n",
    "void main()\n",
    "{\n",
    "    uvec4 place = glbk_sfield_views.places[gl_InstanceID];\n",
    "    uint side = glbk_sfield_views.how.w;\n",
    "    vec2 corner = vec2(float(gl_VertexID & 1) + float(place.x), float(gl_VertexID >> 1) + float(place.y));\n",
    "    sfield_tile = uint(gl_InstanceID);\n",
    "    gl_Position = vec4(2.0 * corner / vec2(6.0, float(glbk_sfield_views.size.x)) - 1.0, 0.0, 1.0);\n",
    "}\n"
};

static const glbk_file glbk__files[] = {
    { "lib/base_bindings.glsl", glbk__glsl_lib_base_bindings_glsl, 2, "", "",
      "" },
    { "lib/cohsm_brdf.glsl", glbk__glsl_lib_cohsm_brdf_glsl, 192, "cohsm_math", "",
      "" },
    { "lib/cohsm_estimate.glsl", glbk__glsl_lib_cohsm_estimate_glsl, 92, "cohsm_brdf cohsm_light", "",
      "" },
    { "lib/cohsm_light.glsl", glbk__glsl_lib_cohsm_light_glsl, 404, "cohsm_math", "",
      "" },
    { "lib/cohsm_lookup.glsl", glbk__glsl_lib_cohsm_lookup_glsl, 251, "", "",
      "" },
    { "lib/cohsm_math.glsl", glbk__glsl_lib_cohsm_math_glsl, 216, "", "",
      "" },
    { "lib/cohsm_visible.glsl", glbk__glsl_lib_cohsm_visible_glsl, 387, "cohsm_math cohsm_lookup", "",
      "" },
    { "lib/csm_access.glsl", glbk__glsl_lib_csm_access_glsl, 8, "table csm_bindings", "",
      "" },
    { "lib/csm_bindings.glsl", glbk__glsl_lib_csm_bindings_glsl, 29, "", "",
      "" },
    { "lib/csm_compress.glsl", glbk__glsl_lib_csm_compress_glsl, 70, "csm_bindings csm_peel", "",
      "" },
    { "lib/csm_frame.glsl", glbk__glsl_lib_csm_frame_glsl, 10, "", "",
      "" },
    { "lib/csm_gbuffer.glsl", glbk__glsl_lib_csm_gbuffer_glsl, 47, "csm_point", "",
      "" },
    { "lib/csm_instances.glsl", glbk__glsl_lib_csm_instances_glsl, 13, "csm_access csm_scene", "",
      "" },
    { "lib/csm_object.glsl", glbk__glsl_lib_csm_object_glsl, 10, "", "",
      "" },
    { "lib/csm_pattern.glsl", glbk__glsl_lib_csm_pattern_glsl, 11, "csm_access csm_frame", "",
      "" },
    { "lib/csm_peel.glsl", glbk__glsl_lib_csm_peel_glsl, 7, "", "",
      "" },
    { "lib/csm_point.glsl", glbk__glsl_lib_csm_point_glsl, 10, "csm_access cohsm_brdf", "",
      "" },
    { "lib/csm_scene.glsl", glbk__glsl_lib_csm_scene_glsl, 5, "", "",
      "" },
    { "lib/csm_shade.glsl", glbk__glsl_lib_csm_shade_glsl, 60, "csm_pattern csm_instances cohsm_visible cohsm_estimate csm_point csm_frame", "",
      "" },
    { "lib/csm_visible.glsl", glbk__glsl_lib_csm_visible_glsl, 8, "csm_instances cohsm_visible csm_scene", "",
      "" },
    { "lib/envsh_access.glsl", glbk__glsl_lib_envsh_access_glsl, 30, "table envsh_bindings envsh_scene", "",
      "" },
    { "lib/envsh_bindings.glsl", glbk__glsl_lib_envsh_bindings_glsl, 14, "", "",
      "" },
    { "lib/envsh_cast.glsl", glbk__glsl_lib_envsh_cast_glsl, 50, "table envsh_bindings envsh_object envsh_scene", "",
      "" },
    { "lib/envsh_chunk.glsl", glbk__glsl_lib_envsh_chunk_glsl, 12, "table envsh_bindings", "",
      "" },
    { "lib/envsh_disc.glsl", glbk__glsl_lib_envsh_disc_glsl, 3, "envsh_bindings envsh_query", "",
      "" },
    { "lib/envsh_group.glsl", glbk__glsl_lib_envsh_group_glsl, 47, "envsh_visible", "",
      "" },
    { "lib/envsh_light.glsl", glbk__glsl_lib_envsh_light_glsl, 14, "envsh_access envsh_disc envsh_visible envsh_query envsh_scene", "",
      "" },
    { "lib/envsh_object.glsl", glbk__glsl_lib_envsh_object_glsl, 8, "", "",
      "" },
    { "lib/envsh_query.glsl", glbk__glsl_lib_envsh_query_glsl, 7, "", "",
      "" },
    { "lib/envsh_scene.glsl", glbk__glsl_lib_envsh_scene_glsl, 6, "", "",
      "" },
    { "lib/envsh_visible.glsl", glbk__glsl_lib_envsh_visible_glsl, 247, "", "",
      "" },
    { "lib/ism_access.glsl", glbk__glsl_lib_ism_access_glsl, 85, "table ism_map ism_bindings ism_frame", "",
      "" },
    { "lib/ism_bindings.glsl", glbk__glsl_lib_ism_bindings_glsl, 25, "", "",
      "" },
    { "lib/ism_blur.glsl", glbk__glsl_lib_ism_blur_glsl, 37, "ism_gbuffer ism_view", "",
      "" },
    { "lib/ism_disc.glsl", glbk__glsl_lib_ism_disc_glsl, 119, "ism_access ism_frame", "",
      "" },
    { "lib/ism_fill.glsl", glbk__glsl_lib_ism_fill_glsl, 55, "ism_access ism_frame", "",
      "" },
    { "lib/ism_frame.glsl", glbk__glsl_lib_ism_frame_glsl, 8, "", "",
      "" },
    { "lib/ism_gbuffer.glsl", glbk__glsl_lib_ism_gbuffer_glsl, 14, "cohsm_math ism_bindings", "",
      "" },
    { "lib/ism_holes.glsl", glbk__glsl_lib_ism_holes_glsl, 25, "ism_fill ism_frame", "",
      "" },
    { "lib/ism_light.glsl", glbk__glsl_lib_ism_light_glsl, 306, "ism_access ism_frame ism_view", "",
      "" },
    { "lib/ism_map.glsl", glbk__glsl_lib_ism_map_glsl, 140, "cohsm_math", "",
      "" },
    { "lib/ism_push.glsl", glbk__glsl_lib_ism_push_glsl, 63, "ism_fill ism_frame", "",
      "" },
    { "lib/ism_view.glsl", glbk__glsl_lib_ism_view_glsl, 5, "", "",
      "" },
    { "lib/prelude.glsl", glbk__glsl_lib_prelude_glsl, 33, "", "",
      "" },
    { "lib/rsm_access.glsl", glbk__glsl_lib_rsm_access_glsl, 17, "rsm_bindings rsm_map", "",
      "" },
    { "lib/rsm_bindings.glsl", glbk__glsl_lib_rsm_bindings_glsl, 40, "", "",
      "" },
    { "lib/rsm_bounce.glsl", glbk__glsl_lib_rsm_bounce_glsl, 35, "rsm_screen rsm_gather rsm_frame", "",
      "" },
    { "lib/rsm_bound.glsl", glbk__glsl_lib_rsm_bound_glsl, 9, "rsm_map rsm_light", "",
      "" },
    { "lib/rsm_chunk.glsl", glbk__glsl_lib_rsm_chunk_glsl, 6, "", "",
      "" },
    { "lib/rsm_direct.glsl", glbk__glsl_lib_rsm_direct_glsl, 51, "rsm_access rsm_bound", "",
      "" },
    { "lib/rsm_drawn.glsl", glbk__glsl_lib_rsm_drawn_glsl, 9, "", "",
      "" },
    { "lib/rsm_frame.glsl", glbk__glsl_lib_rsm_frame_glsl, 13, "", "",
      "" },
    { "lib/rsm_gather.glsl", glbk__glsl_lib_rsm_gather_glsl, 238, "rsm_pick", "",
      "" },
    { "lib/rsm_grid.glsl", glbk__glsl_lib_rsm_grid_glsl, 59, "rsm_screen", "",
      "" },
    { "lib/rsm_light.glsl", glbk__glsl_lib_rsm_light_glsl, 8, "", "",
      "" },
    { "lib/rsm_lists.glsl", glbk__glsl_lib_rsm_lists_glsl, 69, "rsm_screen rsm_frame", "",
      "" },
    { "lib/rsm_map.glsl", glbk__glsl_lib_rsm_map_glsl, 111, "", "",
      "" },
    { "lib/rsm_pick.glsl", glbk__glsl_lib_rsm_pick_glsl, 59, "rsm_access rsm_bound", "",
      "" },
    { "lib/rsm_screen.glsl", glbk__glsl_lib_rsm_screen_glsl, 56, "rsm_access rsm_frame", "",
      "" },
    { "lib/rsm_smooth.glsl", glbk__glsl_lib_rsm_smooth_glsl, 26, "rsm_screen rsm_frame", "",
      "" },
    { "lib/sfield_access.glsl", glbk__glsl_lib_sfield_access_glsl, 10, "table sfield_bindings", "",
      "" },
    { "lib/sfield_bindings.glsl", glbk__glsl_lib_sfield_bindings_glsl, 21, "", "",
      "" },
    { "lib/sfield_field.glsl", glbk__glsl_lib_sfield_field_glsl, 228, "", "",
      "" },
    { "lib/sfield_frame.glsl", glbk__glsl_lib_sfield_frame_glsl, 4, "", "",
      "" },
    { "lib/sfield_gbuffer.glsl", glbk__glsl_lib_sfield_gbuffer_glsl, 53, "sfield_shade sfield_frame sfield_scene", "",
      "" },
    { "lib/sfield_list.glsl", glbk__glsl_lib_sfield_list_glsl, 135, "sfield_access sfield_scene", "",
      "" },
    { "lib/sfield_object.glsl", glbk__glsl_lib_sfield_object_glsl, 7, "", "",
      "" },
    { "lib/sfield_scene.glsl", glbk__glsl_lib_sfield_scene_glsl, 5, "", "",
      "" },
    { "lib/sfield_shade.glsl", glbk__glsl_lib_sfield_shade_glsl, 206, "sfield_access sfield_field sfield_scene", "",
      "" },
    { "lib/sfield_views.glsl", glbk__glsl_lib_sfield_views_glsl, 8, "", "",
      "" },
    { "lib/table.glsl", glbk__glsl_lib_table_glsl, 5, "", "",
      "" },
    { "prog/copy.frag", glbk__glsl_prog_copy_frag, 23, "base_bindings", "screen.vert",
      "TO_COLOR=0 | TO_COLOR=1" },
    { "prog/csm_compress.comp", glbk__glsl_prog_csm_compress_comp, 17, "csm_compress csm_peel", "",
      "" },
    { "prog/csm_compress.frag", glbk__glsl_prog_csm_compress_frag, 19, "csm_compress", "screen.vert",
      "" },
    { "prog/csm_gbuffer.frag", glbk__glsl_prog_csm_gbuffer_frag, 43, "csm_gbuffer csm_object", "csm_gbuffer.vert",
      "" },
    { "prog/csm_gbuffer.vert", glbk__glsl_prog_csm_gbuffer_vert, 19, "csm_bindings csm_object", "",
      "" },
    { "prog/csm_peel.frag", glbk__glsl_prog_csm_peel_frag, 22, "csm_bindings", "csm_peel.vert",
      "CSM_FIRST=1 | CSM_FIRST=0" },
    { "prog/csm_peel.vert", glbk__glsl_prog_csm_peel_vert, 14, "csm_bindings csm_peel", "",
      "" },
    { "prog/csm_query.comp", glbk__glsl_prog_csm_query_comp, 13, "csm_visible csm_frame", "",
      "CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 CSM_INSTANCES=1 | CSM_ASK=1 CSM_FILTER=2 | CSM_ASK=2 CSM_FILTER=1" },
    { "prog/csm_query.frag", glbk__glsl_prog_csm_query_frag, 18, "csm_visible csm_frame", "screen.vert",
      "CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 CSM_INSTANCES=1 | CSM_ASK=1 CSM_FILTER=2 | CSM_ASK=2 CSM_FILTER=1" },
    { "prog/csm_resolve.frag", glbk__glsl_prog_csm_resolve_frag, 11, "csm_bindings csm_frame", "screen.vert",
      "" },
    { "prog/csm_shade.comp", glbk__glsl_prog_csm_shade_comp, 15, "csm_gbuffer csm_shade csm_frame", "",
      "CSM_SHAPE=1 CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 CSM_INSTANCES=1 | CSM_SHAPE=6 CSM_ASK=2 CSM_FILTER=2 COHSM_LOBES=8 CSM_PATTERNS=1" },
    { "prog/csm_shade.frag", glbk__glsl_prog_csm_shade_frag, 14, "csm_gbuffer csm_shade csm_frame", "screen.vert",
      "CSM_SHAPE=1 CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 CSM_INSTANCES=1 | CSM_SHAPE=6 CSM_ASK=2 CSM_FILTER=2 COHSM_LOBES=8 CSM_PATTERNS=1" },
    { "prog/envsh_cast.frag", glbk__glsl_prog_envsh_cast_frag, 13, "envsh_cast", "envsh_cast.vert",
      "ENVSH_RGBA=0 | ENVSH_RGBA=1" },
    { "prog/envsh_cast.vert", glbk__glsl_prog_envsh_cast_vert, 10, "envsh_cast envsh_object", "",
      "ENVSH_RGBA=0 | ENVSH_RGBA=1" },
    { "prog/envsh_cells.frag", glbk__glsl_prog_envsh_cells_frag, 29, "envsh_access envsh_object envsh_scene", "screen.vert",
      "ENVSH_RGBA=0 | ENVSH_RGBA=1" },
    { "prog/envsh_gbuffer.frag", glbk__glsl_prog_envsh_gbuffer_frag, 31, "envsh_bindings envsh_object", "envsh_gbuffer.vert",
      "" },
    { "prog/envsh_gbuffer.vert", glbk__glsl_prog_envsh_gbuffer_vert, 16, "envsh_bindings envsh_object", "",
      "" },
    { "prog/envsh_resolve.frag", glbk__glsl_prog_envsh_resolve_frag, 12, "envsh_bindings envsh_object", "screen.vert",
      "" },
    { "prog/envsh_shade.comp", glbk__glsl_prog_envsh_shade_comp, 83, "envsh_chunk envsh_light envsh_group envsh_query", "",
      "ENVSH_FILTER=0 ENVSH_RGBA=0 | ENVSH_FILTER=1 ENVSH_RGBA=1 | ENVSH_FILTER=2 ENVSH_RGBA=0 | ENVSH_FILTER=3 ENVSH_RGBA=1" },
    { "prog/envsh_shade.frag", glbk__glsl_prog_envsh_shade_frag, 20, "envsh_light envsh_query", "screen.vert",
      "ENVSH_FILTER=0 ENVSH_RGBA=0 | ENVSH_FILTER=1 ENVSH_RGBA=1 | ENVSH_FILTER=2 ENVSH_RGBA=0 | ENVSH_FILTER=3 ENVSH_RGBA=1" },
    { "prog/ism_blur.comp", glbk__glsl_prog_ism_blur_comp, 46, "ism_blur ism_view", "",
      "" },
    { "prog/ism_blur.frag", glbk__glsl_prog_ism_blur_frag, 19, "ism_blur ism_view", "screen.vert",
      "" },
    { "prog/ism_fill.comp", glbk__glsl_prog_ism_fill_comp, 76, "ism_holes ism_push ism_frame", "",
      "ISM_PROJECTION=1 | ISM_PROJECTION=4" },
    { "prog/ism_holes.frag", glbk__glsl_prog_ism_holes_frag, 17, "ism_holes ism_frame", "screen.vert",
      "ISM_PROJECTION=1 | ISM_PROJECTION=4" },
    { "prog/ism_pull.frag", glbk__glsl_prog_ism_pull_frag, 16, "ism_fill ism_frame", "screen.vert",
      "ISM_LEVEL=1 | ISM_LEVEL=2 | ISM_LEVEL=3" },
    { "prog/ism_push.frag", glbk__glsl_prog_ism_push_frag, 22, "ism_push ism_frame", "screen.vert",
      "ISM_PROJECTION=1 | ISM_PROJECTION=4" },
    { "prog/ism_resolve.frag", glbk__glsl_prog_ism_resolve_frag, 10, "ism_bindings ism_view", "screen.vert",
      "" },
    { "prog/ism_shade.comp", glbk__glsl_prog_ism_shade_comp, 48, "ism_gbuffer ism_light ism_view", "",
      "ISM_PROJECTION=1 ISM_NEAR=1 | ISM_PROJECTION=2 ISM_NEAR=2 | ISM_PROJECTION=3 ISM_NEAR=3 | ISM_PROJECTION=4 ISM_NEAR=4 | ISM_NEAR=5 | ISM_NEAR=6" },
    { "prog/ism_shade.frag", glbk__glsl_prog_ism_shade_frag, 16, "ism_gbuffer ism_light ism_view", "screen.vert",
      "ISM_PROJECTION=1 ISM_NEAR=1 | ISM_PROJECTION=2 ISM_NEAR=2 | ISM_PROJECTION=3 ISM_NEAR=3 | ISM_PROJECTION=4 ISM_NEAR=4 | ISM_NEAR=5 | ISM_NEAR=6" },
    { "prog/ism_splat.comp", glbk__glsl_prog_ism_splat_comp, 150, "ism_disc ism_frame", "",
      "ISM_PROJECTION=1 | ISM_PROJECTION=4" },
    { "prog/ism_splat.frag", glbk__glsl_prog_ism_splat_frag, 24, "ism_disc ism_frame", "ism_splat.vert",
      "ISM_PROJECTION=1 ISM_QUADS=0 | ISM_PROJECTION=4 ISM_QUADS=1" },
    { "prog/ism_splat.vert", glbk__glsl_prog_ism_splat_vert, 49, "ism_disc ism_frame", "",
      "" },
    { "prog/rsm_begin.comp", glbk__glsl_prog_rsm_begin_comp, 20, "rsm_lists rsm_frame", "",
      "" },
    { "prog/rsm_direct.frag", glbk__glsl_prog_rsm_direct_frag, 15, "rsm_direct rsm_screen rsm_frame", "screen.vert",
      "" },
    { "prog/rsm_fill.frag", glbk__glsl_prog_rsm_fill_frag, 45, "rsm_bindings rsm_bound rsm_drawn", "rsm_fill.vert",
      "FOR_LIGHT=0 | FOR_LIGHT=1" },
    { "prog/rsm_fill.vert", glbk__glsl_prog_rsm_fill_vert, 16, "rsm_bindings rsm_drawn", "",
      "" },
    { "prog/rsm_gather.comp", glbk__glsl_prog_rsm_gather_comp, 81, "rsm_chunk rsm_bounce rsm_lists rsm_frame", "",
      "NODES=0 | NODES=1 | NODES=0 RSM_SURFACES=1 | NODES=1 RSM_SURFACES=1" },
    { "prog/rsm_gather.frag", glbk__glsl_prog_rsm_gather_frag, 44, "rsm_bounce rsm_frame", "screen.vert",
      "RSM_SURFACES=0 | RSM_SURFACES=1" },
    { "prog/rsm_interpolate.comp", glbk__glsl_prog_rsm_interpolate_comp, 75, "rsm_lists rsm_grid rsm_frame", "",
      "RSM_GROUP=256 | RSM_GROUP=64" },
    { "prog/rsm_interpolate.frag", glbk__glsl_prog_rsm_interpolate_frag, 29, "rsm_grid rsm_frame", "screen.vert",
      "" },
    { "prog/rsm_pick.frag", glbk__glsl_prog_rsm_pick_frag, 52, "rsm_gather rsm_frame", "screen.vert",
      "ALL=0 | ALL=1" },
    { "prog/rsm_recall.frag", glbk__glsl_prog_rsm_recall_frag, 66, "rsm_screen rsm_drawn rsm_frame", "screen.vert",
      "" },
    { "prog/rsm_resolve.frag", glbk__glsl_prog_rsm_resolve_frag, 13, "rsm_access rsm_frame", "screen.vert",
      "" },
    { "prog/rsm_scan.comp", glbk__glsl_prog_rsm_scan_comp, 37, "rsm_pick rsm_light", "",
      "ROWS=0 | ROWS=1" },
    { "prog/rsm_scan.frag", glbk__glsl_prog_rsm_scan_frag, 28, "rsm_pick rsm_frame", "screen.vert",
      "FROM=0 | FROM=1 | FROM=2 | FROM=3" },
    { "prog/rsm_smooth.comp", glbk__glsl_prog_rsm_smooth_comp, 45, "rsm_smooth rsm_frame", "",
      "" },
    { "prog/rsm_smooth.frag", glbk__glsl_prog_rsm_smooth_frag, 23, "rsm_smooth rsm_frame", "screen.vert",
      "" },
    { "prog/screen.vert", glbk__glsl_prog_screen_vert, 5, "", "",
      "" },
    { "prog/sfield_gbuffer.frag", glbk__glsl_prog_sfield_gbuffer_frag, 27, "sfield_bindings sfield_object", "sfield_gbuffer.vert",
      "" },
    { "prog/sfield_gbuffer.vert", glbk__glsl_prog_sfield_gbuffer_vert, 22, "sfield_bindings sfield_object", "",
      "" },
    { "prog/sfield_project.comp", glbk__glsl_prog_sfield_project_comp, 37, "table sfield_bindings sfield_views", "",
      "SFIELD_SOURCE=0 SFIELD_BANDS=4 | SFIELD_SOURCE=1 SFIELD_BANDS=8" },
    { "prog/sfield_project.frag", glbk__glsl_prog_sfield_project_frag, 40, "table sfield_bindings sfield_views", "screen.vert",
      "SFIELD_SOURCE=0 | SFIELD_SOURCE=1" },
    { "prog/sfield_see.frag", glbk__glsl_prog_sfield_see_frag, 19, "sfield_bindings", "sfield_see.vert",
      "SFIELD_SOURCE=0 | SFIELD_SOURCE=1" },
    { "prog/sfield_see.vert", glbk__glsl_prog_sfield_see_vert, 36, "sfield_bindings sfield_views", "",
      "SFIELD_SOURCE=0 | SFIELD_SOURCE=1" },
    { "prog/sfield_shade.comp", glbk__glsl_prog_sfield_shade_comp, 20, "sfield_list sfield_gbuffer", "",
      "SFIELD_BANDS=4 SFIELD_GLOSS=0 | SFIELD_BANDS=3 SFIELD_GLOSS=1 | SFIELD_BANDS=8 SFIELD_GLOSS=0" },
    { "prog/sfield_shade.frag", glbk__glsl_prog_sfield_shade_frag, 20, "sfield_gbuffer", "screen.vert",
      "SFIELD_BANDS=4 SFIELD_GLOSS=0 | SFIELD_BANDS=3 SFIELD_GLOSS=1 | SFIELD_BANDS=8 SFIELD_GLOSS=0" },
    { "prog/sfield_sum.comp", glbk__glsl_prog_sfield_sum_comp, 51, "sfield_bindings sfield_views", "",
      "SFIELD_SOURCE=0 | SFIELD_SOURCE=1" },
    { "prog/sfield_sum.frag", glbk__glsl_prog_sfield_sum_frag, 34, "sfield_bindings sfield_views", "sfield_sum.vert",
      "SFIELD_SOURCE=0 | SFIELD_SOURCE=1" },
    { "prog/sfield_sum.vert", glbk__glsl_prog_sfield_sum_vert, 13, "sfield_bindings sfield_views", "",
      "SFIELD_SOURCE=0 | SFIELD_SOURCE=1" }
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

/* The same of a frame's calls, which ask GL only where the user wants it: its answer makes browsers and drivers with
   threads of their own wait for all that was asked of them before. */
static glbk_result glbk__enter_frame(glbk_context *ctx)
{
    if (!ctx || ctx->check) return glbk__enter(ctx);
    glbk__log_clear(ctx);
    return ctx->lost ? GLBK_ERR_LOST : GLBK_OK;
}

static glbk_result glbk__leave_frame(glbk_context *ctx) { return ctx->check ? glbk__leave(ctx) : GLBK_OK; }

/* The end of a creating call whose last steps were a frame's. */
static glbk_result glbk__made(glbk_context *ctx, glbk_result result)
{
    return result == GLBK_OK ? glbk__leave(ctx) : result;
}

GLBK_DEF glbk_result glbk_check(glbk_context *ctx)
{
    if (!ctx) return GLBK_ERR_ARGUMENT;
    glbk__log_clear(ctx);
    return ctx->lost ? GLBK_ERR_LOST : glbk__leave(ctx);
}

/* ---- >>init: functions and what the context can do ---- */

enum {
    GLBK__GROUP_CORE, GLBK__GROUP_ES, GLBK__GROUP_DESK, GLBK__GROUP_TARGETS, GLBK__GROUP_BLENDS, GLBK__GROUP_COMPUTE,
    GLBK__GROUP_CLIP, GLBK__GROUP_CLAMP
};

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
        const char *name = f->name;
        glbk_proc proc;
        if (f->group != group) continue;
        if (strcmp(name, "glBarrier") == 0) name = "glMemoryBarrier";
        if (group == GLBK__GROUP_CLIP && ctx->es) name = "glClipControlEXT";
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
    ctx->webgl = strstr(text, "WebGL") != NULL;
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

/* Of WebGL's extensions, those are listed too that nobody has enabled: then GL does not know the state. */
static int glbk__has_clip_control(glbk_context *ctx, const glbk_desc *desc)
{
    uint32_t origin;
    if (!ctx->es && ctx->version < 450 && !glbk__has_extension(ctx, "GL_ARB_clip_control")) return 0;
    if (ctx->es && !glbk__has_extension(ctx, "GL_EXT_clip_control")) return 0;
    if (glbk__load(ctx, desc, GLBK__GROUP_CLIP)) return 0;
    origin = glbk__get(ctx, 0x935C /* CLIP_ORIGIN */);
    if (origin == 0x8CA1 || origin == 0x8CA2) return 1;
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
    ctx->compute = desk && ctx->version >= 430 && !desc->core_only && !glbk__load(ctx, desc, GLBK__GROUP_COMPUTE);
    ctx->clip_control = glbk__has_clip_control(ctx, desc);
    ctx->each_target = desk || (es32 && !glbk__load(ctx, desc, GLBK__GROUP_TARGETS));
    ctx->each_blend = ctx->each_target && (es32 || ctx->version >= 400) && !glbk__load(ctx, desc, GLBK__GROUP_BLENDS);
    ctx->offset_clamp = desk && (ctx->version >= 460 || glbk__has_extension(ctx, "GL_ARB_polygon_offset_clamp")) &&
                        !glbk__load(ctx, desc, GLBK__GROUP_CLAMP);
    ctx->max_size = glbk__get(ctx, 0x0D33);
    ctx->max_layers = glbk__get(ctx, 0x88FF);
    ctx->max_targets = glbk__get(ctx, 0x8824 /* MAX_DRAW_BUFFERS */);
    if (ctx->max_targets > 8) ctx->max_targets = 8;
    if (ctx->compute) ctx->max_storage = glbk__get(ctx, 0x90DE /* MAX_SHADER_STORAGE_BLOCK_SIZE */);
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
    if (!missing && !ctx->es) missing = glbk__load(ctx, desc, GLBK__GROUP_TARGETS);
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
    ctx->check = desc->check != 0;
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
    return !glbk__is_depth(f) &&
           (glbk__formats[f].type == GLBK_GL_FLOAT || glbk__formats[f].type == GLBK_GL_HALF_FLOAT);
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
    if (d->sampling == GLBK_SAMPLING_MIPMAPS && d->data && glbk__is_float(d->format) && !ctx->float_targets)
        return GLBK_ERR_FLOAT_TARGET;           /* glGenerateMipmap is for what can be rendered to */
    return GLBK_OK;
}

static uint32_t glbk__half(uint32_t size, uint32_t level) { return size >> level ? size >> level : 1; }

/* ES and WebGL: storage that is allotted once. Of other textures no level may be drawn to while only those below it are
   seen (BASE_LEVEL, MAX_LEVEL), as is done where a pyramid is made. */
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

/* Storage and parameters of the texture that is bound to target. */
static void glbk__fill_texture(const glbk_context *ctx, const glbk_texture_desc *d, uint32_t target)
{
    const glbk__format_info *f = &glbk__formats[d->format];
    int linear = d->sampling == GLBK_SAMPLING_LINEAR || d->sampling == GLBK_SAMPLING_COMPARE;
    int mipmaps = d->sampling == GLBK_SAMPLING_MIPMAPS, wrap = d->repeat ? 0x2901 : 0x812F;
    uint32_t level;

    /* Parameters first: Mesa allots levels by them, and else forgets some of small arrays of integers. */
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
    if (ctx->es) {
        glbk__store_texture(ctx, d, target);
        return;
    }
    for (level = 0; level < d->levels; level++) {
        int32_t width = (int32_t)glbk__half(d->width, level), height = (int32_t)glbk__half(d->height, level);
        const void *data = level == 0 ? d->data : NULL;
        if (d->layers)
            ctx->gl.TexImage3D(target, (int32_t)level, f->internal, width, height, (int32_t)d->layers, 0, f->format,
                               f->type, data);
        else
            ctx->gl.TexImage2D(target, (int32_t)level, f->internal, width, height, 0, f->format, f->type, data);
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

/* What is bound in a texture's place while texels go into it. */
typedef struct glbk__upload {
    glbk__store store;
    int32_t     bound;
} glbk__upload;

static void glbk__upload_begin(const glbk_context *ctx, const glbk_texture *t, glbk__upload *old)
{
    old->bound = 0;
    ctx->gl.GetIntegerv(glbk__binding_of(t->gl_target), &old->bound);
    glbk__store_begin(ctx, GLBK__UNPACK, &old->store);
    ctx->gl.BindTexture(t->gl_target, t->name);
}

static void glbk__upload_end(const glbk_context *ctx, const glbk_texture *t, const glbk__upload *old)
{
    ctx->gl.BindTexture(t->gl_target, (uint32_t)old->bound);
    glbk__store_end(ctx, GLBK__UNPACK, &old->store);
}

static void glbk__upload_box(const glbk_context *ctx, const glbk_texture *t, uint32_t level, uint32_t x, uint32_t y,
                             uint32_t layer, uint32_t width, uint32_t height, uint32_t layers, const void *data)
{
    const glbk__format_info *f = &glbk__formats[t->format];
    if (t->layers)
        ctx->gl.TexSubImage3D(t->gl_target, (int32_t)level, (int32_t)x, (int32_t)y, (int32_t)layer, (int32_t)width,
                              (int32_t)height, (int32_t)layers, f->format, f->type, data);
    else
        ctx->gl.TexSubImage2D(t->gl_target, (int32_t)level, (int32_t)x, (int32_t)y, (int32_t)width, (int32_t)height,
                              f->format, f->type, data);
}

GLBK_DEF glbk_result glbk_texture_update(glbk_context *ctx, const glbk_texture *t, uint32_t level, uint32_t x,
                                         uint32_t y, uint32_t layer, uint32_t width, uint32_t height,
                                         uint32_t layers, const void *data)
{
    glbk__upload old;
    uint32_t wide, high, deep;
    glbk_result result = glbk__enter_frame(ctx);

    if (result != GLBK_OK) return result;
    if (!t || !t->name || !data || level >= t->levels) return GLBK_ERR_ARGUMENT;
    wide = glbk__half(t->width, level);
    high = glbk__half(t->height, level);
    deep = t->layers ? t->layers : 1;
    if (x > wide || width > wide - x || y > high || height > high - y || layer > deep || layers > deep - layer)
        return GLBK_ERR_ARGUMENT;
    glbk__upload_begin(ctx, t, &old);
    glbk__upload_box(ctx, t, level, x, y, layer, width, height, layers, data);
    glbk__upload_end(ctx, t, &old);
    return glbk__leave_frame(ctx);
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
    if (result == GLBK_OK && texels) result = glbk__made(ctx, glbk_table_update(ctx, out, 0, count, texels));
    if (result != GLBK_OK) glbk_texture_destroy(ctx, out);
    return result;
}

/* A run of texels is up to three boxes in each layer: the rest of a row, whole rows, the beginning of a row. */
GLBK_DEF glbk_result glbk_table_update(glbk_context *ctx, const glbk_texture *table, size_t first, size_t count,
                                       const void *texels)
{
    const size_t side = GLBK__TABLE_SIDE;
    const unsigned char *from = (const unsigned char *)texels;
    glbk__upload old;
    size_t room;
    glbk_result result;

    if (!ctx || !table || !table->name || table->width != side || !table->layers || !texels) return GLBK_ERR_ARGUMENT;
    room = side * table->height * table->layers;
    if (first > room || count > room - first) return GLBK_ERR_ARGUMENT;
    result = glbk__enter_frame(ctx);
    if (result != GLBK_OK || !count) return result;
    glbk__upload_begin(ctx, table, &old);
    while (count) {
        size_t x = first % side, y = first / side % side, layer = first / side / side, width, height = 1;
        if (x || count < side) {
            width = count < side - x ? count : side - x;
        } else {
            width = side;
            height = count / side < side - y ? count / side : side - y;
        }
        glbk__upload_box(ctx, table, 0, (uint32_t)x, (uint32_t)y, (uint32_t)layer, (uint32_t)width, (uint32_t)height,
                         1, from);
        from += width * height * glbk__formats[table->format].bytes;
        first += width * height;
        count -= width * height;
    }
    glbk__upload_end(ctx, table, &old);
    return glbk__leave_frame(ctx);
}

/* ---- >>buffers: through the copy target, which no vertex array or draw looks at ---- */

enum { GLBK__DYNAMIC_DRAW = 0x88E8 };

static glbk_result glbk__buffer_make(glbk_context *ctx, size_t size, const void *data, int indices, glbk_buffer *out)
{
    const uint32_t target = indices ? GLBK_GL_ELEMENT_ARRAY_BUFFER : GLBK_GL_COPY_WRITE_BUFFER;
    int32_t bound = 0;
    glbk_result result;

    if (!out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    result = glbk__enter(ctx);
    if (result != GLBK_OK) return result;
    if (!size) return GLBK_ERR_ARGUMENT;
    if (size > PTRDIFF_MAX) return GLBK_ERR_LIMIT;
    ctx->gl.GetIntegerv(indices ? 0x8895 /* ELEMENT_ARRAY_BUFFER_BINDING */ : target, &bound);
    ctx->gl.GenBuffers(1, &out->name);
    ctx->gl.BindBuffer(target, out->name);
    ctx->gl.BufferData(target, (ptrdiff_t)size, data, GLBK_GL_STATIC_DRAW);
    ctx->gl.BindBuffer(target, (uint32_t)bound);
    out->size = size;
    result = glbk__leave(ctx);
    if (result != GLBK_OK) glbk_buffer_destroy(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_buffer_create(glbk_context *ctx, size_t size, const void *data, glbk_buffer *out)
{
    return glbk__buffer_make(ctx, size, data, 0, out);
}

/* WebGL remembers what a buffer was bound to first. Elsewhere through the copy target as well: this one belongs to the
   vertex array, and core profiles need not have one bound. */
GLBK_DEF glbk_result glbk_indices_create(glbk_context *ctx, size_t size, const void *data, glbk_buffer *out)
{
    return glbk__buffer_make(ctx, size, data, ctx && ctx->webgl, out);
}

static int glbk__inside(const glbk_buffer *buffer, size_t offset, size_t size)
{
    return buffer && buffer->name && offset <= buffer->size && size <= buffer->size - offset;
}

GLBK_DEF glbk_result glbk_buffer_update(glbk_context *ctx, const glbk_buffer *buffer, size_t offset, size_t size,
                                        const void *data)
{
    const uint32_t target = GLBK_GL_COPY_WRITE_BUFFER;
    int32_t bound = 0;
    glbk_result result = glbk__enter_frame(ctx);

    if (result != GLBK_OK) return result;
    if (!data || !glbk__inside(buffer, offset, size)) return GLBK_ERR_ARGUMENT;
    ctx->gl.GetIntegerv(target, &bound);
    ctx->gl.BindBuffer(target, buffer->name);
    if (size == buffer->size) ctx->gl.BufferData(target, (ptrdiff_t)size, data, GLBK__DYNAMIC_DRAW);
    else ctx->gl.BufferSubData(target, (ptrdiff_t)offset, (ptrdiff_t)size, data);
    ctx->gl.BindBuffer(target, (uint32_t)bound);
    return glbk__leave_frame(ctx);
}

/* All values of a block or storage buffer for the draws that follow, bound to its slot: two calls, which go through the
   binding that a pass changes anyway. The storage is new, so that nothing waits for the draws before, copies what they
   read or, on GPUs that draw tile by tile, splits their pass. */
static glbk_result glbk__put_values(glbk_context *ctx, uint32_t target, uint32_t slot, const glbk_buffer *buffer,
                                    const void *values)
{
    glbk_result result = glbk__enter_frame(ctx);
    if (ctx->lost || !buffer->name) return ctx->lost ? GLBK_ERR_LOST : GLBK_ERR_ARGUMENT;
    if (target == GLBK_GL_UNIFORM_BUFFER) slot += ctx->first_block;
    ctx->gl.BindBufferBase(target, slot, buffer->name);         /* even so: a callback may draw in spite of an error */
    if (result != GLBK_OK) return result;
    ctx->gl.BufferData(target, (ptrdiff_t)buffer->size, values, GLBK_GL_STREAM_DRAW);
    return glbk__leave_frame(ctx);
}

static glbk_result glbk__put_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer, const void *values)
{
    return glbk__put_values(ctx, GLBK_GL_UNIFORM_BUFFER, slot, buffer, values);
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

/* Without colours, a framebuffer is complete in OpenGL 3.3 only where none is to be read from either; 4.1 dropped
   that. */
static void glbk__read_nothing(const glbk_context *ctx, uint32_t name)
{
    int32_t bound = 0;
    ctx->gl.GetIntegerv(0x8CAA /* READ_FRAMEBUFFER_BINDING */, &bound);
    ctx->gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, name);
    ctx->gl.ReadBuffer(0);
    ctx->gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, (uint32_t)bound);
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
    if (!out->count) {
        buffers[0] = 0;
        glbk__read_nothing(ctx, out->name);
    }
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

/* A texture and the target that is drawn to it. */
static glbk_result glbk__canvas(glbk_context *ctx, glbk_format format, uint32_t width, uint32_t height,
                                const glbk_texture *depth, glbk_texture *texture, glbk_target *target)
{
    glbk_texture_desc d;
    glbk_target_desc t;
    glbk_result result;
    memset(&d, 0, sizeof d);
    memset(&t, 0, sizeof t);
    d.format = format;
    d.width = width;
    d.height = height;
    t.color[0] = texture;
    t.depth = depth;
    result = glbk_texture_create(ctx, &d, texture);
    return result == GLBK_OK ? glbk_target_create(ctx, &t, target) : result;
}

static glbk__allocator glbk__memory(const glbk_context *ctx)
{
    return glbk__allocator_make(ctx->allocator.alloc_fn, ctx->allocator.free_fn, ctx->allocator.user);
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

static int glbk__is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
static int glbk__is_name(char c) { return glbk__is_letter(c) || (c >= '0' && c <= '9'); }

static int glbk__gather(glbk__list *list, const char *names);

/* Adds a library file after what it uses itself, unless it is there. The depth is that of the embedded files, which
   tests/gl walks. */
static int glbk__gather_file(glbk__list *list, const glbk_file *file)
{
    uint32_t i;
    if (!file || !glbk__gather(list, file->uses)) return 0;
    for (i = 0; i < list->count && list->file[i] != file; i++) {}
    if (i < list->count) return 1;
    if (list->count == GLBK__MAX_FILES) return 0;
    list->file[list->count++] = file;
    return 1;
}

/* The library files named; 0 where one is unknown. */
static int glbk__gather(glbk__list *list, const char *names)
{
    size_t length;
    for (; (length = glbk__word(&names)) != 0; names += length)
        if (!glbk__gather_file(list, glbk__find("lib/", names, length, ".glsl"))) return 0;
    return 1;
}

/* Uniform blocks that a text names; the files of blocks begin with "// NAME, uniform block". No others are declared, as
   what is declared needs a buffer whether it is read or not (std140; WebGL 2 refuses to draw). */
static int glbk__gather_blocks(glbk__list *list, const char *text)
{
    size_t i;
    for (i = 0; i < sizeof glbk__files / sizeof glbk__files[0]; i++) {
        const char *name = glbk__files[i].lines[0] + 3, *end = strchr(name, ','), *at = text;
        size_t length = end ? (size_t)(end - name) : 0;
        if (!length || strcmp(end, ", uniform block\n") != 0) continue;
        while ((at = strstr(at, "glbk_")) != NULL && (strncmp(at, name, length) != 0 || glbk__is_name(at[length])))
            at++;
        if (at && !glbk__gather_file(list, &glbk__files[i])) return 0;
    }
    return 1;
}

/* Of a shader: its files before its own. */
static int glbk__gather_all(glbk__list *list, const char *uses, const glbk_file *main_file, const char *text)
{
    list->count = 0;
    return glbk__gather(list, "prelude") && glbk__gather(list, uses ? uses : "") &&
           glbk__gather(list, main_file ? main_file->uses : "") && glbk__gather_blocks(list, text ? text : "");
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

/* "#line n001 n": line 4 of file 3 is 3004 in the driver's messages. Mesa forgets the file number, hence
   the thousands. */
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

static int glbk__is_value(char c) { return glbk__is_name(c) || c == '.' || c == '-'; }

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
    if (!glbk__gather_all(&list, uses, main_file, main_text)) return 0;
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

    (void)glbk__gather_all(&list, uses, main_file, stage->text);    /* all are there: the text was compiled */
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
    glbk__allocator memory = glbk__memory(ctx);
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

/* Each list ends with an entry of its own, since C knows no empty arrays. A user's own samplers stand behind ours. */
static const glbk__slot glbk__texture_slots[] = {
#define GLBK__ENTRY(type, name, slot) { #name, slot },
#define GLBK__LIST(part, PART) GLBK_##PART##_TEXTURES(GLBK__ENTRY)
    GLBK_PARTS(GLBK__LIST)
#undef GLBK__LIST
#undef GLBK__ENTRY
    { "glbk_user0", GLBK_SLOT_glbk_user0 }, { "glbk_user1", GLBK_SLOT_glbk_user1 },
    { "glbk_user2", GLBK_SLOT_glbk_user2 }, { "glbk_user3", GLBK_SLOT_glbk_user3 },
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

   X(group, GL's name, value that a pass needs): BOTH, or DESK for OpenGL alone. PROGRAM_POINT_SIZE and MULTISAMPLE are
   on because ES has no switch for them and behaves so; the rest must not interfere. SRGB: only of targets that have
   such a format, which ES encodes, too. In the user's framebuffer it is a matter of the user's. */

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
    X(SRGB, 0x8DB9, 1) /* FRAMEBUFFER_SRGB */                           \
    X(DESK, 0x884F, 1) /* TEXTURE_CUBE_MAP_SEAMLESS */                  \
    X(DESK, 0x3000, 0) X(DESK, 0x3001, 0) X(DESK, 0x3002, 0) X(DESK, 0x3003, 0) /* CLIP_DISTANCE */  \
    X(DESK, 0x3004, 0) X(DESK, 0x3005, 0) X(DESK, 0x3006, 0) X(DESK, 0x3007, 0)

enum { GLBK__CAP_BOTH, GLBK__CAP_DESK, GLBK__CAP_RESTART, GLBK__CAP_SRGB };

static const struct { uint32_t name; int group, value; } glbk__caps[] = {
#define GLBK__ENTRY(group, name, value) { name, GLBK__CAP_##group, value },
    GLBK__CAPS(GLBK__ENTRY)
#undef GLBK__ENTRY
};
enum { GLBK__CAP_COUNT = sizeof glbk__caps / sizeof glbk__caps[0] };

static int glbk__has_cap(const glbk_context *ctx, int i)
{
    if (glbk__caps[i].group == GLBK__CAP_RESTART) return ctx->es ? !ctx->webgl : ctx->version >= 430;    /* WebGL: on */
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
    GLBK__W_STORAGE = GLBK__WORD_COUNT, GLBK__W_GROUPS, GLBK__W_ORIGIN, GLBK__W_CLIP_DEPTH, GLBK__W_POLYGON,
    GLBK__W_POLYGON_2
};

static const uint32_t glbk__word_names[] = {
#define GLBK__ENTRY(name, gl) gl,
    GLBK__WORDS(GLBK__ENTRY)
#undef GLBK__ENTRY
};

enum { GLBK__BLEND = 0x0BE2, GLBK__COLOR_MASK = 0x0C23 };

/* Words from SOURCE_RGB to EQUATION_ALPHA. */
enum { GLBK__BLEND_WORDS = 6 };

static void glbk__save_indexed(glbk_context *ctx, glbk_state *s)
{
    uint32_t i, k;
    if (!ctx->each_target) {
        ctx->gl.GetBooleanv(GLBK__COLOR_MASK, s->color_mask[0]);
        return;
    }
    for (i = 0; i < ctx->max_targets; i++) {
        s->blend[i] = ctx->gl.IsEnabledi(GLBK__BLEND, i);
        ctx->gl.GetBooleani_v(GLBK__COLOR_MASK, i, s->color_mask[i]);
        for (k = 0; k < GLBK__BLEND_WORDS && ctx->each_blend; k++)
            ctx->gl.GetIntegeri_v(glbk__word_names[GLBK__W_SOURCE_RGB + k], i, &s->blends[i][k]);
    }
}

enum { GLBK__GROUPS = 0x90EE /* DISPATCH_INDIRECT_BUFFER */ };

/* IMAGE_BINDING_NAME, _LEVEL, _LAYERED, _LAYER, _ACCESS, _FORMAT. */
static const uint32_t glbk__image_names[6] = { 0x8F3A, 0x8F3B, 0x8F3C, 0x8F3D, 0x8F3E, 0x906E };

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
        ctx->gl.BindImageTexture(i, (uint32_t)m[0], m[1], (uint8_t)(m[2] != 0), m[3], (uint32_t)m[4], (uint32_t)m[5]);
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
    if (ctx->compute) {
        ctx->gl.GetIntegerv(0x90D3, &out->words[GLBK__W_STORAGE]);
        ctx->gl.GetIntegerv(0x90EF, &out->words[GLBK__W_GROUPS]);
        glbk__save_images(ctx, out);
    }
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
    if (ctx->offset_clamp) ctx->gl.GetFloatv(0x8E1B /* POLYGON_OFFSET_CLAMP */, &out->offset_clamp);
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
    if (!ctx->compute) return;
    ctx->gl.BindBuffer(GLBK_GL_SHADER_STORAGE_BUFFER, (uint32_t)s->words[GLBK__W_STORAGE]);
    ctx->gl.BindBuffer(GLBK__GROUPS, (uint32_t)s->words[GLBK__W_GROUPS]);
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
    if (!ctx->es) ctx->gl.PolygonMode(0x0408, (uint32_t)w[GLBK__W_POLYGON]);
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

static int glbk__has_srgb(const glbk_target *target)
{
    uint32_t i;
    for (i = 0; target && i < target->count; i++)
        if (target->format[i] == GLBK_FORMAT_SRGB8_A8) return 1;
    return 0;
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
        if (glbk__has_cap(ctx, i) && (glbk__caps[i].group != GLBK__CAP_SRGB || glbk__has_srgb(pass->target)))
            glbk__set_cap(ctx, glbk__caps[i].name, glbk__caps[i].value);
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
        uint32_t words[4];
        int i;
        if (target->format[attachment] == GLBK_FORMAT_RGBA32UI && !ctx->float_targets) {
            memcpy(words, rgba, sizeof words);      /* floats by their bits */
        } else {
            for (i = 0; i < 4; i++)
                words[i] = rgba[i] > 0 ? (uint32_t)(rgba[i] < 4294967296.0f ? (double)rgba[i] + 0.5 : 4294967295.0) : 0;
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
    if (!ctx || ctx->lost || slot >= GLBK_UNITS) return;
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
    if (!ctx || ctx->lost || !buffer || slot >= GLBK_BLOCKS) return;
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
    ctx->gl.BindImageTexture(slot, texture->name, 0, texture->layers != 0, 0, 0x88BA /* READ_WRITE */,
                             (uint32_t)glbk__formats[texture->format].internal);
}

GLBK_DEF void glbk_draw_screen(glbk_context *ctx)
{
    if (ctx && !ctx->lost) ctx->gl.DrawArrays(GLBK_GL_TRIANGLES, 0, 3);
}

static glbk_result glbk__before_dispatch(glbk_context *ctx, glbk_program *program)
{
    if (!ctx || !program || !program->name) return GLBK_ERR_ARGUMENT;
    if (ctx->lost) return GLBK_ERR_LOST;
    if (!ctx->compute) return GLBK_ERR_FEATURE;
    glbk_program_use(ctx, program);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_dispatch(glbk_context *ctx, glbk_program *program, uint32_t x, uint32_t y, uint32_t z)
{
    glbk_result result = glbk__before_dispatch(ctx, program);
    if (result != GLBK_OK) return result;
    ctx->gl.DispatchCompute(x, y, z);
    ctx->gl.Barrier(GLBK_GL_ALL_BARRIER_BITS);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_dispatch_indirect(glbk_context *ctx, glbk_program *program, const glbk_buffer *groups,
                                            size_t offset)
{
    glbk_result result = glbk__before_dispatch(ctx, program);
    if (result != GLBK_OK) return result;
    if (!groups || !groups->name || offset % 4 || offset + 12 > groups->size) return GLBK_ERR_ARGUMENT;
    ctx->gl.BindBuffer(GLBK__GROUPS, groups->name);
    ctx->gl.DispatchComputeIndirect((ptrdiff_t)offset);
    ctx->gl.Barrier(GLBK_GL_ALL_BARRIER_BITS);
    return GLBK_OK;
}

/* Where a resolve draws its picture: the corner of the viewport, ints by their bits. See glbk_pass. */
static glbk_result glbk__corner(glbk_context *ctx, const glbk_pass *pass, uint32_t width, uint32_t height,
                                uint32_t corner[2])
{
    const int32_t *v = pass->viewport;
    const int whole = pass->target && !v[2] && !v[3];
    const uint32_t wide = whole ? pass->target->width : (uint32_t)v[2];
    const uint32_t high = whole ? pass->target->height : (uint32_t)v[3];

    corner[0] = whole ? 0u : (uint32_t)v[0];
    corner[1] = whole ? 0u : (uint32_t)v[1];
    if (wide <= width && high <= height) return GLBK_OK;
    glbk__log_clear(ctx);
    glbk__log(ctx, "the viewport is larger than the picture: ");
    glbk__log_number(ctx, width, 10);
    glbk__log(ctx, " x ");
    glbk__log_number(ctx, height, 10);
    return GLBK_ERR_ARGUMENT;
}

/* ---- techniques: one section each; src/README.md says how ---- */

/* ---- >>csm: blocks and instances ---- */

enum { GLBK__CSM_RECORD = 4, GLBK__CSM_MAGIC = 0x4d534344 };

/* Magic, format and length, as docs/csm-format.md has them; in the host's byte order, which is what GL takes. */
static int glbk__csm_block_valid(const glbk_csm_block *b)
{
    uint32_t head[3];
    if (!b->data || b->size < 400 || b->size % 16) return 0;
    memcpy(head, b->data, sizeof head);
    return head[0] == GLBK__CSM_MAGIC && head[1] == 1 && head[2] == b->size / 4;
}

enum { GLBK__CSM_NEAR = 16, GLBK__CSM_NEAR_TEXELS = 11, GLBK__CSM_HEAD = 28 /* words: texels 1 to 7 of a block */ };

static void glbk__csm_define(glbk__sink *sink, const char *name, uint32_t value)
{
    char digit = (char)('0' + value % 10);
    if (!value) return;
    glbk__put_text(sink, name);
    if (value > 9) glbk__put_text(sink, "1");
    glbk__put(sink, &digit, 1);
}

/* What programs for these blocks alone can be compiled with, and a number for it: domain, order and frame, 0 where
   blocks differ; instances and headers in the uniform block where they fit. */
static void glbk__csm_write_defines(const glbk_csm_block *blocks, size_t count, glbk_csm_maps *out)
{
    static const uint32_t word[3] = { 0, 2, 3 }, most[3] = { 9, 4, 3 };     /* of the header's texel 1 */
    uint32_t kind[3] = { 0, 0, 0 }, head[GLBK__CSM_HEAD], k;
    glbk__sink sink = { NULL, 0, 0 };
    size_t i;
    for (i = 0; i < count; i++) {
        memcpy(head, (const char *)blocks[i].data + 16, sizeof head);
        if (i < GLBK__CSM_NEAR) memcpy(out->heads[i], head, sizeof head);
        for (k = 0; k < 3; k++)
            kind[k] = head[word[k]] <= most[k] && (i == 0 || kind[k] == head[word[k]]) ? head[word[k]] : 0;
    }
    if (count <= GLBK__CSM_NEAR && out->capacity <= GLBK__CSM_NEAR)
        out->near_count = out->capacity <= 1 ? 1 : GLBK__CSM_NEAR;
    sink.out = out->defines;
    sink.size = sizeof out->defines;
    glbk__csm_define(&sink, " COHSM_ONE_DOMAIN=", kind[0]);
    glbk__csm_define(&sink, " COHSM_ONE_ORDER=", kind[1]);
    glbk__csm_define(&sink, " COHSM_ONE_FRAME=", kind[2]);
    glbk__csm_define(&sink, " CSM_INSTANCES=", out->near_count);
    out->key = ((kind[0] * 8 + kind[1]) * 4 + kind[2]) * 4 + (out->near_count > 1 ? 2 : out->near_count);
}

GLBK_DEF glbk_result glbk_csm_maps_create(glbk_context *ctx, const glbk_csm_block *blocks, size_t count,
                                          uint32_t capacity, uint32_t *starts, glbk_csm_maps *out)
{
    size_t texels = 0, i;
    glbk_result result;

    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (count && (!blocks || !starts)) return GLBK_ERR_ARGUMENT;
    for (i = 0; i < count; i++) {
        if (!glbk__csm_block_valid(&blocks[i])) return GLBK_ERR_ARGUMENT;
        if (blocks[i].size / 16 > ((size_t)1 << 28) - texels) return GLBK_ERR_LIMIT;
        starts[i] = (uint32_t)texels;
        if (i < GLBK__CSM_NEAR) out->starts[i] = starts[i];
        texels += blocks[i].size / 16;
        texels += (size_t)-(ptrdiff_t)texels & 3u;      /* lines of 64 bytes do not straddle rows then */
    }
    if (capacity > ((uint32_t)1 << 28) / GLBK__CSM_RECORD) return GLBK_ERR_LIMIT;
    out->texels = (uint32_t)texels;
    out->capacity = capacity;
    glbk__csm_write_defines(blocks, count, out);
    result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, texels + 1, &out->blocks);
    if (result == GLBK_OK && !out->near_count)
        result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, GLBK__CSM_RECORD * (size_t)capacity + 1,
                                   &out->instances);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_csm_scene), NULL, &out->scene);
    for (i = 0; i < count && result == GLBK_OK; i++)
        result = glbk_table_update(ctx, &out->blocks, starts[i], blocks[i].size / 16, blocks[i].data);
    if (result == GLBK_OK) result = glbk__made(ctx, glbk_csm_maps_place(ctx, out, NULL, 0));
    if (result != GLBK_OK) glbk_csm_maps_destroy(ctx, out);
    return result;
}

/* Four texels: the way into the object's space, its block. */
static void glbk__csm_record(const glbk_csm_instance *instance, uint32_t *words)
{
    float inverse[16], row[4];
    uint32_t r, c;
    glbk__m4_affine_inverse(inverse, instance->transform);
    for (r = 0; r < 3; r++) {
        for (c = 0; c < 4; c++) row[c] = inverse[4 * c + r];
        memcpy(words + 4 * r, row, sizeof row);
    }
    words[12] = instance->start;
    memcpy(words + 13, &instance->offset, 4);
    words[14] = words[15] = 0;
}

/* Instances and the headers of their blocks into the uniform block. */
static void glbk__csm_place_near(const glbk_csm_maps *maps, const glbk_csm_instance *instances, uint32_t count,
                                 glbk_csm_scene *scene)
{
    uint32_t i, block;
    for (i = 0; i < count; i++) {
        uint32_t *to = scene->instances + 4 * GLBK__CSM_NEAR_TEXELS * i;
        glbk__csm_record(&instances[i], to);
        for (block = 0; block + 1 < GLBK__CSM_NEAR && maps->starts[block] != instances[i].start;) block++;
        memcpy(to + 4 * GLBK__CSM_RECORD, maps->heads[block], sizeof maps->heads[block]);
    }
}

/* All of them into their table at once. */
static glbk_result glbk__csm_place_many(glbk_context *ctx, const glbk_csm_maps *maps,
                                        const glbk_csm_instance *instances, uint32_t count)
{
    glbk__allocator memory = glbk__memory(ctx);
    uint32_t *words = (uint32_t *)glbk__alloc_array(&memory, count, 4 * 4 * GLBK__CSM_RECORD), i;
    glbk_result result;
    if (!words) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i++) glbk__csm_record(&instances[i], words + 4 * GLBK__CSM_RECORD * (size_t)i);
    result = glbk_table_update(ctx, &maps->instances, 0, GLBK__CSM_RECORD * (size_t)count, words);
    glbk__free(&memory, words);
    return result;
}

GLBK_DEF glbk_result glbk_csm_maps_place(glbk_context *ctx, glbk_csm_maps *maps, const glbk_csm_instance *instances,
                                         uint32_t count)
{
    glbk_csm_scene scene;
    float inverse[16], scale;
    glbk_result result = GLBK_OK;
    uint32_t i;

    if (!ctx || !maps || !maps->blocks.name || count > maps->capacity || (count && !instances))
        return GLBK_ERR_ARGUMENT;
    for (i = 0; i < count; i++)
        if (instances[i].start >= maps->texels || !glbk__m4_is_rigid_uniform(instances[i].transform, &scale) ||
            !glbk__m4_affine_inverse(inverse, instances[i].transform))
            return GLBK_ERR_ARGUMENT;
    memset(&scene, 0, sizeof scene);
    if (maps->near_count) glbk__csm_place_near(maps, instances, count, &scene);
    else if (count) result = glbk__csm_place_many(ctx, maps, instances, count);
    if (result != GLBK_OK) return result;
    maps->count = count;
    scene.table[1] = count;
    scene.table[2] = maps->near_count != 0;
    return glbk_buffer_update(ctx, &maps->scene, 0, sizeof scene, &scene);
}

GLBK_DEF void glbk_csm_bind(glbk_context *ctx, const glbk_csm_maps *maps)
{
    if (!maps) return;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_blocks, &maps->blocks);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_instances, maps->instances.name ? &maps->instances : &maps->blocks);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_csm_scene, &maps->scene);
}

GLBK_DEF void glbk_csm_maps_destroy(glbk_context *ctx, glbk_csm_maps *maps)
{
    if (!maps) return;
    glbk_texture_destroy(ctx, &maps->blocks);
    glbk_texture_destroy(ctx, &maps->instances);
    glbk_buffer_destroy(ctx, &maps->scene);
    memset(maps, 0, sizeof *maps);
}

/* ---- >>csm: programs that are kept ---- */

/* The place of a key: where it is kept, else a free one, else the one that was used longest ago; NULL where all are of
   this frame, which would compile the same programs again and again. */
static glbk_program *glbk__csm_keep_program(glbk_context *ctx, glbk_csm_programs *cache, uint32_t key, uint32_t *at)
{
    uint32_t i, oldest = 0;
    for (i = 0; i < cache->count && cache->keys[i] != key; i++)
        if (cache->frame - cache->used[i] > cache->frame - cache->used[oldest]) oldest = i;
    if (i == GLBK_CSM_MAX_PROGRAMS) {
        if (cache->used[oldest] == cache->frame) return NULL;
        i = oldest;
        glbk_program_destroy(ctx, &cache->list[i]);
        cache->keys[i] = UINT32_MAX;        /* of none, should its successor not compile */
    }
    *at = i;
    return &cache->list[i];
}

/* defines: of this use; those of the maps follow. fragment: the user's shader in place of the named one, or NULL. */
static glbk_result glbk__csm_program(glbk_context *ctx, glbk_csm_programs *cache, uint32_t key, const char *name,
                                     const char *fragment, const char *defines, const glbk_csm_maps *maps,
                                     glbk_program **out)
{
    char all[160] = { 0 };
    glbk__sink sink = { NULL, 0, 0 };
    glbk_source source;
    glbk_result result;
    uint32_t i;

    key = key << 11 | maps->key;
    *out = glbk__csm_keep_program(ctx, cache, key, &i);
    if (!*out) return GLBK_ERR_LIMIT;
    cache->used[i] = cache->frame;
    if ((*out)->name) return GLBK_OK;
    sink.out = all;
    sink.size = sizeof all;
    glbk__put_text(&sink, defines);
    glbk__put_text(&sink, maps->defines);
    if (fragment) {
        memset(&source, 0, sizeof source);
        source.fragment = fragment;
        source.uses = "csm_gbuffer csm_shade";
        source.defines = all;
        result = glbk_program_compile(ctx, &source, *out);
    } else {
        result = glbk_program_create(ctx, name, all, *out);
    }
    if (result != GLBK_OK) return result;
    cache->keys[i] = key;
    if (i == cache->count) cache->count++;
    return GLBK_OK;
}

static void glbk__csm_programs_destroy(glbk_context *ctx, glbk_csm_programs *cache)
{
    uint32_t i;
    for (i = 0; i < cache->count; i++) glbk_program_destroy(ctx, &cache->list[i]);
    cache->count = 0;
}

/* ---- >>csm: questions in bulk ---- */

static glbk_result glbk__csm_ask_program(glbk_context *ctx, glbk_csm_asker *asker, const glbk_csm_maps *maps,
                                         glbk_program **out)
{
    char defines[] = "CSM_ASK=0 CSM_FILTER=0";
    uint32_t question = asker->question - 1;
    asker->programs.frame++;
    defines[8] = (char)('0' + question / 3);
    defines[21] = (char)('0' + question % 3);
    return glbk__csm_program(ctx, &asker->programs, question, asker->asked.name ? "csm_query.comp" : "csm_query.frag",
                             NULL, defines, maps, out);
}

GLBK_DEF glbk_result glbk_csm_asker_create(glbk_context *ctx, uint32_t capacity, glbk_csm_asker *out)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result;

    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!capacity || capacity > (uint32_t)1 << 20) return GLBK_ERR_ARGUMENT;
    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    out->capacity = capacity;
    result = glbk_buffer_create(ctx, sizeof(glbk_csm_frame), NULL, &out->frame);
    if (result == GLBK_OK && ctx->compute && 32 * (size_t)capacity <= ctx->max_storage) {
        result = glbk_buffer_create(ctx, 32 * (size_t)capacity, NULL, &out->asked);
        if (result == GLBK_OK) result = glbk_buffer_create(ctx, 4 * (size_t)capacity, NULL, &out->answered);
    } else if (result == GLBK_OK) {
        result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, 2 * (size_t)capacity, &out->questions);
        texture.format = GLBK_FORMAT_R32UI;
        texture.width = 1024;
        texture.height = (capacity + 1023) / 1024;
        if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &out->answers);
        target.color[0] = &out->answers;
        if (result == GLBK_OK) result = glbk_target_create(ctx, &target, &out->target);
    }
    if (result != GLBK_OK) glbk_csm_asker_destroy(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_csm_ask_upload(glbk_context *ctx, glbk_csm_asker *asker, const glbk_csm_questions *q)
{
    glbk_csm_frame frame;
    glbk_result result;

    if (!ctx || !asker || !asker->capacity || !q || !q->items || !q->count || q->count > asker->capacity ||
        (unsigned)q->ask >= GLBK_CSM_ASK_COUNT || (unsigned)q->filter >= GLBK_CSM_FILTER_COUNT || !(q->bias >= 0))
        return GLBK_ERR_ARGUMENT;
    asker->question = 1 + 3 * (uint32_t)q->ask + (uint32_t)q->filter;
    memset(&frame, 0, sizeof frame);
    frame.range[0] = q->count;
    frame.range[3] = q->seed;
    frame.query[0] = q->bias;
    result = glbk_buffer_update(ctx, &asker->frame, 0, sizeof frame, &frame);
    if (result != GLBK_OK) return result;
    if (asker->asked.name) return glbk_buffer_update(ctx, &asker->asked, 0, 32 * (size_t)q->count, q->items);
    return glbk_table_update(ctx, &asker->questions, 0, 2 * (size_t)q->count, q->items);
}

GLBK_DEF glbk_result glbk_csm_ask_run(glbk_context *ctx, glbk_csm_asker *asker, const glbk_csm_maps *maps,
                                      uint32_t count)
{
    glbk_pass pass;
    glbk_program *program;
    glbk_result result;
    uint32_t groups = (count + 63) / 64;

    if (!ctx || !asker || !maps || !count || count > asker->capacity || !asker->question) return GLBK_ERR_ARGUMENT;
    result = glbk__csm_ask_program(ctx, asker, maps, &program);
    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    if (!asker->asked.name) {
        pass.target = &asker->target;
        pass.viewport[2] = 1024;
        pass.viewport[3] = (int32_t)((count + 1023) / 1024);
        result = glbk_begin(ctx, &pass, program);
        if (result != GLBK_OK) return result;
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_questions, &asker->questions);
    }
    glbk_csm_bind(ctx, maps);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_csm_frame, &asker->frame);
    if (!asker->asked.name) {
        glbk_draw_screen(ctx);
        return GLBK_OK;
    }
    glbk_bind_storage(ctx, GLBK_SLOT_glbk_csm_asked, &asker->asked);
    glbk_bind_storage(ctx, GLBK_SLOT_glbk_csm_answers, &asker->answered);
    return glbk_dispatch(ctx, program, groups < 1024 ? groups : 1024, (groups + 1023) / 1024, 1);
}

GLBK_DEF glbk_result glbk_csm_ask_read(glbk_context *ctx, glbk_csm_asker *asker, uint32_t count, float *visible)
{
    uint32_t row[4 * 1024], done, n, i;
    glbk_result result = GLBK_OK;

    if (!ctx || !asker || !visible || !count || count > asker->capacity) return GLBK_ERR_ARGUMENT;
    if (asker->asked.name) return glbk_buffer_read(ctx, &asker->answered, 0, 4 * (size_t)count, visible);
    for (done = 0; done < count && result == GLBK_OK; done += n) {
        n = count - done < 1024 ? count - done : 1024;
        result = glbk_target_read(ctx, &asker->target, 0, 0, done / 1024, n, 1, row);
        for (i = 0; i < n && result == GLBK_OK; i++) memcpy(visible + done + i, row + 4 * i, 4);
    }
    return result;
}

GLBK_DEF void glbk_csm_asker_destroy(glbk_context *ctx, glbk_csm_asker *asker)
{
    if (!asker) return;
    glbk__csm_programs_destroy(ctx, &asker->programs);
    glbk_target_destroy(ctx, &asker->target);
    glbk_texture_destroy(ctx, &asker->questions);
    glbk_texture_destroy(ctx, &asker->answers);
    glbk_buffer_destroy(ctx, &asker->frame);
    glbk_buffer_destroy(ctx, &asker->asked);
    glbk_buffer_destroy(ctx, &asker->answered);
    memset(asker, 0, sizeof *asker);
}

/* ---- >>csm: lights ---- */

/* A light in a table (docs/gpu-layouts.md): ten texels, then its texels of L, running sums, triangles. */
enum { GLBK__CSM_LIGHT_HEAD = 10, GLBK__CSM_TEXTURED = 1, GLBK__CSM_ORTHOGONAL = 2 };

#define GLBK__PI 3.14159265358979324

static int glbk__csm_is_sky(const glbk_csm_light_desc *d)
{
    return d->shape == GLBK_CSM_SHAPE_DEFAULT || d->shape == GLBK_CSM_SHAPE_ENVIRONMENT;
}

static int glbk__csm_in_range(const float *v, int count, float low, float high)
{
    int i;
    for (i = 0; i < count; i++)
        if (!(v[i] >= low && v[i] <= high)) return 0;
    return 1;
}

static int glbk__csm_is_unit(const float *v)
{
    float square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    return square > 0.998f && square < 1.002f;
}

static int glbk__csm_is_shape(glbk_csm_shape shape)
{
    return (unsigned)shape < GLBK_CSM_SHAPE_COUNT && (unsigned)shape != 9;     /* COHSM_SHAPE_CALLBACK */
}

static int glbk__csm_light_valid(const glbk_csm_light_desc *d)
{
    const float big = 1e18f;
    int flat = !d->texels;

    if (!glbk__csm_is_shape(d->shape) || !glbk__csm_in_range(d->radiance, 3, 0, 3e38f) ||
        !glbk__csm_in_range(&d->cosine_power, 1, 0, 1e5f) || !glbk__csm_in_range(&d->rotation, 1, -1000, 1000) ||
        !glbk__csm_in_range(d->position, 3, -big, big))
        return 0;
    if (flat ? d->width || d->height : !d->width || !d->height || d->width > 65536 || d->height > 65536) return 0;
    switch (d->shape) {
    case GLBK_CSM_SHAPE_SUN: return flat && glbk__csm_is_unit(d->direction);
    case GLBK_CSM_SHAPE_POINT: return flat;
    case GLBK_CSM_SHAPE_SPOT:
        return flat && glbk__csm_is_unit(d->direction) && glbk__csm_in_range(&d->cone_angle, 1, 1e-6f, 6.2831855f);
    case GLBK_CSM_SHAPE_LINE:
        return glbk__csm_in_range(d->u, 3, -big, big) && (d->u[0] != 0 || d->u[1] != 0 || d->u[2] != 0) &&
               glbk__csm_in_range(&d->radius, 1, 1e-18f, big) && (flat || d->height == 1);
    case GLBK_CSM_SHAPE_RECTANGLE: {
        glbk__v3 n = glbk__v3_cross(glbk__v3_load(d->u), glbk__v3_load(d->v));
        return glbk__csm_in_range(d->u, 3, -big, big) && glbk__csm_in_range(d->v, 3, -big, big) &&
               glbk__v3_length(n) > 0 && glbk__finite(glbk__v3_length(n));
    }
    case GLBK_CSM_SHAPE_DISC:
        return glbk__csm_is_unit(d->direction) && glbk__csm_in_range(&d->radius, 1, 1e-18f, big);
    case GLBK_CSM_SHAPE_SPHERE: return glbk__csm_in_range(&d->radius, 1, 1e-18f, big);
    case GLBK_CSM_SHAPE_MESH: return flat && d->triangles && d->triangle_count && d->triangle_count < (uint32_t)1 << 26;
    default: return d->cosine_power == 0;
    }
}

GLBK_DEF size_t glbk_csm_light_texels(const glbk_csm_light_desc *d)
{
    size_t cells;
    if (!d || !glbk__csm_light_valid(d)) return 0;
    if (d->shape == GLBK_CSM_SHAPE_MESH) return GLBK__CSM_LIGHT_HEAD + 3 * (size_t)d->triangle_count;
    if (!d->texels) return glbk__csm_is_sky(d) ? GLBK__CSM_LIGHT_HEAD + 3 : GLBK__CSM_LIGHT_HEAD;
    cells = (size_t)d->width * d->height;
    return cells > (size_t)1 << 27 ? 0 : GLBK__CSM_LIGHT_HEAD + 2 * cells + d->height;
}

static void glbk__csm_put(uint32_t *words, uint32_t texel, glbk__v3 v, float w)
{
    float f[4];
    glbk__v3_store(f, v);
    f[3] = w;
    memcpy(words + 4 * (size_t)texel, f, sizeof f);
}

/* Running sums, divided by the total, of `count` weights that stand in w of the texels at `sums`; then for each
   fraction i / count of the total where a search for it begins and ends. Returns the total. */
static double glbk__csm_sums(uint32_t *sums, uint32_t count, double total)
{
    double sum = 0;
    float before, after = 0, weight;
    uint32_t i, lo = 0;

    for (i = 0; i < count; i++) {
        memcpy(&weight, sums + 4 * (size_t)i + 3, 4);
        sum += (double)weight;
        before = after;
        after = total > 0 ? i + 1 < count ? (float)(sum / total) : 1.0f : 0.0f;
        memcpy(sums + 4 * (size_t)i, &before, 4);
        memcpy(sums + 4 * (size_t)i + 1, &after, 4);
    }
    for (i = 0; i < count; i++) {
        memcpy(&after, sums + 4 * (size_t)lo + 1, 4);
        while (lo + 1 < count && (double)after <= (double)i / count) {
            lo++;
            memcpy(&after, sums + 4 * (size_t)lo + 1, 4);
        }
        sums[4 * (size_t)i + 2] = lo;
        sums[4 * (size_t)i + 3] = count;
        if (i) sums[4 * (size_t)i - 1] = lo + 1;
    }
    return sum;
}

/* Texels of L, the sums of each row and of the rows; returns what turns a texel into its density. */
static glbk__v3 glbk__csm_texture(const glbk_csm_light_desc *d, uint32_t *words, uint32_t w, uint32_t h)
{
    static const float white[3] = { 1, 1, 1 };
    uint32_t *texels = words + 4 * GLBK__CSM_LIGHT_HEAD, *rows = texels + 4 * (size_t)w * h, *row, x, y, c;
    float top = d->radiance[0] > d->radiance[1] ? d->radiance[0] : d->radiance[1], rgb[4] = { 0, 0, 0, 0 };
    glbk__v3 tint = glbk__v3_make(1, 1, 1);
    double total = 0, sum, weight;

    top = top > d->radiance[2] ? top : d->radiance[2];
    if (top > 0) tint = glbk__v3_make(d->radiance[0] / top, d->radiance[1] / top, d->radiance[2] / top);
    tint = glbk__v3_scale(tint, 1.0f / 3.0f);
    for (y = 0; y < h; y++) {
        row = rows + 4 * ((size_t)h + (size_t)y * w);
        sum = 0;
        for (x = 0; x < w; x++) {
            const float *from = d->texels ? d->texels + 3 * ((size_t)y * w + x) : white;
            float density;
            for (c = 0; c < 3; c++) rgb[c] = glbk__finite(from[c]) && from[c] > 0 ? from[c] : 0;
            density = glbk__v3_dot(glbk__v3_load(rgb), tint);
            memcpy(texels + 4 * ((size_t)y * w + x), rgb, sizeof rgb);
            memcpy(row + 4 * (size_t)x + 3, &density, 4);
            sum += (double)density;
        }
        glbk__csm_sums(row, w, sum);
        /* of the sky: solid angle of the row, cos a - cos b, without loss of digits */
        weight = glbk__csm_is_sky(d) ? 2 * sin(GLBK__PI * (2.0 * y + 1) / (2.0 * h)) * sin(GLBK__PI / (2.0 * h)) : 1;
        rgb[3] = (float)(sum * weight);
        memcpy(rows + 4 * (size_t)y + 3, &rgb[3], 4);
        total += (double)rgb[3];
        rgb[3] = 0;
    }
    glbk__csm_sums(rows, h, total);
    if (!(total > 0)) return glbk__v3_make(0, 0, 0);
    return glbk__v3_scale(tint, (float)(glbk__csm_is_sky(d) ? w / (2 * GLBK__PI * total) : (double)w * h / total));
}

/* Corners, and the share of all area up to the end of each triangle. Returns the area. */
static float glbk__csm_triangles(const glbk_csm_light_desc *d, uint32_t *texels)
{
    double total = 0, sum = 0;
    uint32_t i, pass;

    for (pass = 0; pass < 2; pass++)
        for (i = 0; i < d->triangle_count; i++) {
            glbk__v3 a = glbk__v3_load(d->triangles + 9 * (size_t)i),
                     b = glbk__v3_load(d->triangles + 9 * (size_t)i + 3);
            glbk__v3 c = glbk__v3_load(d->triangles + 9 * (size_t)i + 6);
            double area = 0.5 * (double)glbk__v3_length(glbk__v3_cross(glbk__v3_sub(b, a), glbk__v3_sub(c, a)));
            if (!pass) {
                total += area;
                continue;
            }
            sum += area;
            glbk__csm_put(texels, 3 * i, a, (float)(sum / total));
            glbk__csm_put(texels, 3 * i + 1, b, 0);
            glbk__csm_put(texels, 3 * i + 2, c, 0);
        }
    return (float)total;
}

typedef struct glbk__csm_geometry { glbk__v3 n, ex, ey; float lx, ly, area; uint32_t flags; } glbk__csm_geometry;

static glbk__csm_geometry glbk__csm_geometry_of(const glbk_csm_light_desc *d)
{
    glbk__csm_geometry g;
    glbk__v3 u = glbk__v3_load(d->u), v = glbk__v3_load(d->v);

    memset(&g, 0, sizeof g);
    g.n = glbk__v3_normalize(glbk__v3_load(d->direction));
    g.area = 1;
    if (d->shape == GLBK_CSM_SHAPE_LINE) {
        g.n = glbk__v3_normalize(u);
        g.lx = glbk__v3_length(u);
    } else if (d->shape == GLBK_CSM_SHAPE_DISC) {
        glbk__v3_basis(g.n, &g.ex, &g.ey);
        g.area = (float)GLBK__PI * d->radius * d->radius;
    } else if (d->shape == GLBK_CSM_SHAPE_SPHERE) {
        g.area = 4 * (float)GLBK__PI * d->radius * d->radius;
    } else if (d->shape == GLBK_CSM_SHAPE_RECTANGLE) {
        glbk__v3 n = glbk__v3_cross(u, v);
        float uv = glbk__v3_dot(u, v);
        g.area = glbk__v3_length(n);
        g.n = glbk__v3_normalize(n);
        g.lx = glbk__v3_length(u);
        g.ly = glbk__v3_length(v);
        g.ex = glbk__v3_scale(glbk__v3_cross(v, g.n), 1.0f / g.area);
        g.ey = glbk__v3_scale(glbk__v3_cross(g.n, u), 1.0f / g.area);
        if ((uv < 0 ? -uv : uv) <= 1e-5f * g.area) g.flags |= GLBK__CSM_ORTHOGONAL;
    }
    return g;
}

GLBK_DEF glbk_result glbk_csm_light_write(const glbk_csm_light_desc *d, uint32_t *words)
{
    glbk__csm_geometry g;
    uint32_t w, h, shape;
    glbk__v3 tint = glbk__v3_make(0, 0, 0);

    if (!words || !glbk_csm_light_texels(d)) return GLBK_ERR_ARGUMENT;
    g = glbk__csm_geometry_of(d);
    shape = glbk__csm_is_sky(d) ? (uint32_t)GLBK_CSM_SHAPE_ENVIRONMENT : (uint32_t)d->shape;
    w = d->texels ? d->width : 1;
    h = d->texels ? d->height : 1;
    memset(words, 0, 16 * GLBK__CSM_LIGHT_HEAD);
    if (d->texels || glbk__csm_is_sky(d)) {
        g.flags |= GLBK__CSM_TEXTURED;
        tint = glbk__csm_texture(d, words, w, h);
    }
    if (d->shape == GLBK_CSM_SHAPE_MESH) g.area = glbk__csm_triangles(d, words + 4 * GLBK__CSM_LIGHT_HEAD);
    if (!(g.area > 0)) return GLBK_ERR_ARGUMENT;
    words[0] = shape;
    words[1] = w;
    words[2] = h;
    words[3] = g.flags;
    words[4] = GLBK__CSM_LIGHT_HEAD;
    words[5] = GLBK__CSM_LIGHT_HEAD + w * h;
    words[6] = GLBK__CSM_LIGHT_HEAD;
    words[7] = d->triangle_count;
    glbk__csm_put(words, 2, glbk__v3_load(d->position), d->radius);
    glbk__csm_put(words, 3, g.n, g.lx);
    glbk__csm_put(words, 4, g.ex, g.ly);
    glbk__csm_put(words, 5, g.ey, g.area);
    glbk__csm_put(words, 6, glbk__v3_load(d->radiance), (float)cos(0.5 * (double)d->cone_angle));
    glbk__csm_put(words, 7, tint, (float)((double)d->rotation / (2 * GLBK__PI)));
    glbk__csm_put(words, 8, glbk__v3_load(d->u), d->cosine_power);
    glbk__csm_put(words, 9, glbk__v3_load(d->v), 0);
    return GLBK_OK;
}

static void glbk__csm_write_lobes(const glbk_csm_lights_desc *d, uint32_t *words)
{
    uint32_t i;
    for (i = 0; i < d->lobe_count; i++) {
        glbk__csm_put(words, 2 * i, glbk__v3_load(d->lobes[i].axis), d->lobes[i].exponent);
        glbk__csm_put(words, 2 * i + 1, glbk__v3_load(d->lobes[i].scale), 0);
    }
}

GLBK_DEF glbk_result glbk_csm_lights_create(glbk_context *ctx, const glbk_csm_lights_desc *d, uint32_t *starts,
                                            glbk_csm_lights *out)
{
    glbk__allocator memory;
    size_t texels, one, patterns;
    uint32_t i, *words;
    glbk_result result = GLBK_OK;

    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!d || (d->light_count && (!d->lights || !starts)) || (d->lobe_count && !d->lobes) ||
        d->lobe_count > (uint32_t)1 << 20 || (d->patterns != NULL) != (d->pattern_length != 0) ||
        d->pattern_length > 65536)
        return GLBK_ERR_ARGUMENT;
    texels = 2 * (size_t)d->lobe_count;
    patterns = 128 * (size_t)d->pattern_length;
    for (i = 0; i < d->light_count; i++) {
        one = glbk_csm_light_texels(&d->lights[i]);
        if (!one) return GLBK_ERR_ARGUMENT;
        starts[i] = (uint32_t)texels;
        texels += one;
        if (texels > (size_t)1 << 28) return GLBK_ERR_LIMIT;
    }
    out->lobe_count = d->lobe_count;
    out->patterns_at = (uint32_t)texels;
    out->pattern_length = d->pattern_length;
    texels += patterns + 1;
    memory = glbk__memory(ctx);
    words = (uint32_t *)glbk__alloc_array(&memory, texels, 16);
    if (!words) return GLBK_ERR_ALLOC;
    memset(words, 0, texels * 16);
    glbk__csm_write_lobes(d, words);
    for (i = 0; i < d->light_count && result == GLBK_OK; i++)
        result = glbk_csm_light_write(&d->lights[i], words + 4 * (size_t)starts[i]);
    if (patterns) memcpy(words + 4 * (size_t)out->patterns_at, d->patterns, patterns * 16);
    if (result == GLBK_OK) result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, words, texels, &out->texels);
    glbk__free(&memory, words);
    if (result != GLBK_OK) memset(out, 0, sizeof *out);
    return result;
}

GLBK_DEF glbk_result glbk_csm_lights_update(glbk_context *ctx, glbk_csm_lights *lights, uint32_t start,
                                            const glbk_csm_light_desc *desc)
{
    glbk__allocator memory;
    size_t texels = glbk_csm_light_texels(desc);
    uint32_t *words;
    glbk_result result;

    if (!ctx || !lights || !lights->texels.name || !texels || start < 2 * lights->lobe_count ||
        start > lights->patterns_at || texels > lights->patterns_at - start)
        return GLBK_ERR_ARGUMENT;
    memory = glbk__memory(ctx);
    words = (uint32_t *)glbk__alloc_array(&memory, texels, 16);
    if (!words) return GLBK_ERR_ALLOC;
    result = glbk_csm_light_write(desc, words);
    if (result == GLBK_OK) result = glbk_table_update(ctx, &lights->texels, start, texels, words);
    glbk__free(&memory, words);
    return result;
}

GLBK_DEF void glbk_csm_lights_destroy(glbk_context *ctx, glbk_csm_lights *lights)
{
    if (!lights) return;
    glbk_texture_destroy(ctx, &lights->texels);
    memset(lights, 0, sizeof *lights);
}

/* ---- >>csm: the renderer ---- */

/* The program for one combination of shape, ask and filter; compiled when it is first asked for. */
static uint32_t glbk__csm_shape_of(const glbk_csm_use *u)
{
    return u->shape == GLBK_CSM_SHAPE_DEFAULT ? (uint32_t)GLBK_CSM_SHAPE_ENVIRONMENT : (uint32_t)u->shape;
}

static glbk_result glbk__csm_shade_program(glbk_context *ctx, glbk_csm_renderer *r, const glbk_csm_use *use,
                                           uint32_t filter, glbk_program **out)
{
    char defines[] = "CSM_ASK=0 CSM_FILTER=0 COHSM_LOBES=1 CSM_SHAPE=10 CSM_PATTERNS";
    uint32_t shape = glbk__csm_shape_of(use), ask = (uint32_t)use->ask;
    defines[8] = (char)('0' + ask);
    defines[21] = (char)('0' + filter);
    defines[35] = (char)('0' + r->lobes);
    if (shape < 10) {
        defines[47] = (char)('0' + shape);
        defines[48] = ' ';
    }
    if (!r->patterns) defines[49] = 0;
    return glbk__csm_program(ctx, &r->shade, shape * 16 + ask * 4 + filter,
                             r->compute ? "csm_shade.comp" : "csm_shade.frag", r->fragment, defines, use->maps, out);
}

static glbk_result glbk__csm_create_gbuffer(glbk_context *ctx, glbk_csm_renderer *r)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result = GLBK_OK;
    int i;

    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    texture.format = GLBK_FORMAT_RGBA32UI;
    texture.width = r->width;
    texture.height = r->height;
    for (i = 0; i < 4 && result == GLBK_OK; i++) {
        result = glbk_texture_create(ctx, &texture, &r->gbuffer[i]);
        target.color[i] = &r->gbuffer[i];
    }
    texture.format = GLBK_FORMAT_DEPTH32F;
    if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &r->depth);
    target.depth = &r->depth;
    if (result == GLBK_OK) result = glbk_target_create(ctx, &target, &r->gbuffer_target);
    if (result == GLBK_OK) result = glbk_program_create(ctx, "csm_gbuffer.frag", NULL, &r->fill);
    return result;
}

static glbk_result glbk__csm_create_sums(glbk_context *ctx, glbk_csm_renderer *r)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result = GLBK_OK;
    int i;

    memset(&texture, 0, sizeof texture);
    texture.format = GLBK_FORMAT_COLOR;
    texture.width = r->width;
    texture.height = r->height;
    for (i = 0; i < (r->compute ? 1 : 2) && result == GLBK_OK; i++) {
        memset(&target, 0, sizeof target);
        result = glbk_texture_create(ctx, &texture, &r->sums[i]);
        target.color[0] = &r->sums[i];
        if (result == GLBK_OK) result = glbk_target_create(ctx, &target, &r->targets[i]);
    }
    return result;
}

GLBK_DEF glbk_result glbk_csm_renderer_create(glbk_context *ctx, const glbk_csm_renderer_desc *d,
                                              glbk_csm_renderer *out)
{
    glbk_result result;

    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!d || !d->width || !d->height || d->lobes > 8) return GLBK_ERR_ARGUMENT;
    out->width = d->width;
    out->height = d->height;
    out->compute = ctx->compute && !d->fragment;
    out->fragment = d->fragment;
    out->lobes = d->lobes ? d->lobes : 1;
    out->patterns = d->patterns != 0;
    result = glbk_program_create(ctx, "csm_resolve.frag", NULL, &out->resolve);
    if (result == GLBK_OK && !d->fragment) result = glbk__csm_create_gbuffer(ctx, out);
    if (result == GLBK_OK) result = glbk__csm_create_sums(ctx, out);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_csm_frame), NULL, &out->frame);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_csm_object), NULL, &out->object);
    if (result != GLBK_OK) glbk_csm_renderer_destroy(ctx, out);
    return result;
}

GLBK_DEF void glbk_csm_renderer_destroy(glbk_context *ctx, glbk_csm_renderer *r)
{
    uint32_t i;
    if (!r) return;
    glbk__csm_programs_destroy(ctx, &r->shade);
    glbk_program_destroy(ctx, &r->fill);
    glbk_program_destroy(ctx, &r->resolve);
    glbk_target_destroy(ctx, &r->gbuffer_target);
    for (i = 0; i < 4; i++) glbk_texture_destroy(ctx, &r->gbuffer[i]);
    glbk_texture_destroy(ctx, &r->depth);
    for (i = 0; i < 2; i++) {
        glbk_target_destroy(ctx, &r->targets[i]);
        glbk_texture_destroy(ctx, &r->sums[i]);
    }
    glbk_buffer_destroy(ctx, &r->frame);
    glbk_buffer_destroy(ctx, &r->object);
    memset(r, 0, sizeof *r);
}

/* A unit vector in 32 bits, octahedral, as csm_unpack_unit of lib/csm_gbuffer.glsl reads it; ~0 for zero. */
static uint32_t glbk__csm_pack_unit(const float *v)
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

/* The four words that a material keeps besides its diffuse colour. */
static void glbk__csm_gloss(const glbk_csm_surface *s, float *gloss)
{
    memset(gloss, 0, 4 * sizeof *gloss);
    if (s->brdf == GLBK_CSM_BRDF_PHONG) {
        memcpy(gloss, s->specular, sizeof s->specular);
        gloss[3] = s->exponent;
    } else if (s->brdf == GLBK_CSM_BRDF_METAL_ROUGH) {
        gloss[0] = s->metallic;
        gloss[1] = s->roughness;
    }
}

static void glbk__csm_pixel_words(const glbk_csm_pixel *p, uint32_t *const words[4], size_t at)
{
    const glbk_csm_surface *s = &p->surface;
    memcpy(words[0] + at, p->position, 12);
    words[0][at + 3] = s->self;
    memcpy(words[1] + at, p->normal, 12);
    words[1][at + 3] = (uint32_t)s->brdf | (s->plane & 255u) << 8;
    memcpy(words[2] + at, s->diffuse, 12);
    words[2][at + 3] = glbk__csm_pack_unit(p->geometric);
    if (s->brdf == GLBK_CSM_BRDF_LAFORTUNE) {
        words[3][at] = s->lobe;
        words[3][at + 1] = s->lobe_count;
        words[3][at + 2] = glbk__csm_pack_unit(p->tangent);
        words[3][at + 3] = 0;
    } else {
        float gloss[4];
        glbk__csm_gloss(s, gloss);
        memcpy(words[3] + at, gloss, sizeof gloss);
    }
}

GLBK_DEF glbk_result glbk_csm_gbuffer_upload(glbk_context *ctx, glbk_csm_renderer *r, uint32_t row, uint32_t rows,
                                             const glbk_csm_pixel *pixels)
{
    glbk__allocator memory;
    size_t count, i;
    uint32_t *words[4];
    glbk_result result = GLBK_OK;
    int k;

    if (!ctx || !r || !r->gbuffer[0].name || !rows || row >= r->height || rows > r->height - row || !pixels)
        return GLBK_ERR_ARGUMENT;
    memory = glbk__memory(ctx);
    count = (size_t)r->width * rows;
    words[0] = (uint32_t *)glbk__alloc_array(&memory, count, 64);
    if (!words[0]) return GLBK_ERR_ALLOC;
    for (k = 1; k < 4; k++) words[k] = words[k - 1] + 4 * count;
    for (i = 0; i < count; i++) glbk__csm_pixel_words(&pixels[i], words, 4 * i);
    for (k = 0; k < 4 && result == GLBK_OK; k++)
        result = glbk_texture_update(ctx, &r->gbuffer[k], 0, 0, row, 0, r->width, rows, 1, words[k]);
    glbk__free(&memory, words[0]);
    return result;
}

GLBK_DEF glbk_result glbk_csm_gbuffer_begin(glbk_context *ctx, glbk_csm_renderer *r)
{
    static const float zero[4] = { 0, 0, 0, 0 };
    glbk_pass pass;
    glbk_result result;
    uint32_t i;

    if (!ctx || !r || !r->gbuffer_target.name) return GLBK_ERR_ARGUMENT;
    memset(&pass, 0, sizeof pass);
    pass.target = &r->gbuffer_target;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_begin(ctx, &pass, &r->fill);
    if (result != GLBK_OK) return result;
    for (i = 0; i < 4; i++) glbk_clear(ctx, &r->gbuffer_target, i, zero);
    glbk_clear_depth(ctx, 1);
    for (i = 0; i < 3; i++) glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_color_map + i, NULL);    /* until one has a map */
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_gbuffer_object(glbk_context *ctx, glbk_csm_renderer *r, const glbk_csm_draw *d)
{
    glbk_csm_object object;
    glbk_result result;

    if (!ctx || !r || !r->fill.name || !d || d->surface.lobe_count > 8) return GLBK_ERR_ARGUMENT;
    memset(&object, 0, sizeof object);
    memcpy(object.world, d->world, sizeof object.world);
    memcpy(object.clip, d->clip, sizeof object.clip);
    memcpy(object.eye, d->eye, sizeof d->eye);
    memcpy(object.diffuse, d->surface.diffuse, sizeof d->surface.diffuse);
    object.kinds[0] = (uint32_t)d->surface.brdf;
    object.kinds[1] = d->surface.self;
    object.kinds[2] = d->surface.plane & 255u;
    object.kinds[3] = (d->diffuse_map ? 1u : 0u) | (d->specular_map ? 2u : 0u) | (d->normal_map ? 4u : 0u);
    object.lobes[0] = d->surface.lobe;
    object.lobes[1] = d->surface.lobe_count;
    glbk__csm_gloss(&d->surface, object.gloss);
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_csm_object, &r->object, &object);
    if (result != GLBK_OK) return result;
    if (d->diffuse_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_color_map, d->diffuse_map);
    if (d->specular_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_gloss_map, d->specular_map);
    if (d->normal_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_normal_map, d->normal_map);
    return GLBK_OK;
}

static int glbk__csm_frame_valid(const glbk_csm_renderer *r, const glbk_csm_frame_desc *d)
{
    uint32_t i;
    if (!r || !r->targets[0].name || !d || !d->lights || !d->lights->texels.name || (d->use_count && !d->uses) ||
        d->plane_count > GLBK_CSM_MAX_PLANES || (unsigned)d->sampling >= GLBK_CSM_SAMPLING_COUNT ||
        (unsigned)d->filter >= GLBK_CSM_FILTER_COUNT || !(d->bias >= 0) || !(d->offset >= 0) || r->frames == UINT32_MAX)
        return 0;
    for (i = 0; i < d->use_count; i++) {
        const glbk_csm_use *u = &d->uses[i];
        if (!u->maps || !u->maps->blocks.name || (unsigned)u->ask >= GLBK_CSM_ASK_COUNT ||
            !glbk__csm_is_shape(u->shape) || !u->samples || u->samples > 65536 ||
            u->start < 2 * d->lights->lobe_count || u->start >= d->lights->patterns_at ||
            (r->patterns && u->samples != d->lights->pattern_length))
            return 0;
    }
    return 1;
}

/* Samples from .. to of one light. */
static glbk_result glbk__csm_shade_pass(glbk_context *ctx, glbk_csm_renderer *r, const glbk_csm_use *use,
                                        const glbk_csm_lights *lights, const glbk_csm_frame *frame,
                                        glbk_program *program)
{
    glbk_pass pass;
    glbk_result result = glbk__put_block(ctx, GLBK_SLOT_glbk_csm_frame, &r->frame, frame);
    uint32_t i;

    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    pass.target = &r->targets[!r->now];
    if (!r->compute) result = glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    glbk_csm_bind(ctx, use->maps);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_lights, &lights->texels);
    for (i = 0; i < 4; i++) glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_place + i, &r->gbuffer[i]);
    r->passes = 1;
    if (r->compute) {
        glbk_bind_image(ctx, GLBK_SLOT_glbk_csm_total, &r->sums[0]);
        return glbk_dispatch(ctx, program, (r->width + 7) / 8, (r->height + 7) / 8, 1);
    }
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_sum, &r->sums[r->now]);
    glbk_draw_screen(ctx);
    r->now = !r->now;
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_prepare(glbk_context *ctx, glbk_csm_renderer *r, const glbk_csm_frame_desc *d)
{
    glbk_result result = GLBK_OK;
    glbk_program *program;
    uint32_t i;

    if (!ctx || !glbk__csm_frame_valid(r, d)) return GLBK_ERR_ARGUMENT;
    r->shade.frame++;
    for (i = 0; i < d->use_count && result == GLBK_OK; i++)
        result = glbk__csm_shade_program(ctx, r, &d->uses[i], (uint32_t)d->filter, &program);
    return result;
}

GLBK_DEF glbk_result glbk_csm_render(glbk_context *ctx, glbk_csm_renderer *r, const glbk_csm_frame_desc *d)
{
    glbk_csm_frame frame;
    glbk_program *program;
    glbk_result result;
    uint32_t i, from, step;

    if (!ctx || !glbk__csm_frame_valid(r, d)) return GLBK_ERR_ARGUMENT;
    result = glbk_csm_prepare(ctx, r, d);
    if (result != GLBK_OK) return result;
    memset(&frame, 0, sizeof frame);
    step = d->samples_per_pass ? d->samples_per_pass : 64;
    memcpy(frame.eye, d->eye, sizeof d->eye);
    memcpy(frame.planes, d->planes, sizeof d->planes);
    frame.query[0] = d->bias;
    frame.query[1] = d->offset;
    frame.tables[0] = d->lights->patterns_at;
    frame.tables[1] = d->plane_count;
    frame.tables[2] = r->width;
    frame.tables[3] = r->height;
    for (i = 0; i < d->use_count && result == GLBK_OK; i++) {
        const glbk_csm_use *u = &d->uses[i];
        result = glbk__csm_shade_program(ctx, r, u, (uint32_t)d->filter, &program);
        frame.light[0] = u->start;
        frame.light[2] = u->maps->count;
        frame.light[3] = (uint32_t)u->ask;
        frame.sampling[0] = u->samples;
        frame.sampling[1] = u->seed;
        frame.sampling[2] = d->number;
        frame.sampling[3] = (uint32_t)d->sampling;
        frame.range[2] = (uint32_t)d->filter;
        frame.range[3] = u->seed * 0x9e3779b9u + d->number * 0x85ebca6bu;
        for (from = 0; from < u->samples && result == GLBK_OK; from = frame.range[1]) {
            frame.range[0] = from;
            frame.range[1] = u->samples - from < step ? u->samples : from + step;
            frame.query[3] = r->passes ? 1.0f : 0.0f;
            result = glbk__csm_shade_pass(ctx, r, u, d->lights, &frame, program);
        }
    }
    if (result == GLBK_OK) r->frames++;
    return result;
}

GLBK_DEF void glbk_csm_reset(glbk_csm_renderer *r)
{
    if (r) r->frames = r->passes = 0;
}

GLBK_DEF glbk_result glbk_csm_resolve(glbk_context *ctx, glbk_csm_renderer *r, const glbk_pass *pass)
{
    glbk_csm_frame frame;
    glbk_result result;

    if (!ctx || !r || !r->resolve.name || !pass) return GLBK_ERR_ARGUMENT;
    memset(&frame, 0, sizeof frame);
    frame.query[2] = r->passes ? 1.0f / (float)r->frames : 0.0f;
    result = glbk__corner(ctx, pass, r->width, r->height, frame.range);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_csm_frame, &r->frame, &frame);
    if (result != GLBK_OK) return result;
    result = glbk_begin(ctx, pass, &r->resolve);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_sum, &r->sums[r->now]);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_read(glbk_context *ctx, glbk_csm_renderer *r, float *rgba)
{
    glbk_result result;
    size_t i, count;
    float scale;

    if (!ctx || !r || !r->targets[0].name || !r->frames || !rgba) return GLBK_ERR_ARGUMENT;
    count = 4 * (size_t)r->width * r->height;
    if (!r->passes) {
        memset(rgba, 0, count * sizeof *rgba);
        return GLBK_OK;
    }
    result = glbk_target_read(ctx, &r->targets[r->now], 0, 0, 0, r->width, r->height, rgba);
    scale = 1.0f / (float)r->frames;
    for (i = 0; i < count && result == GLBK_OK; i++) rgba[i] *= scale;
    return result;
}

/* ---- >>csm: building ---- */

enum { GLBK__CSM_ATLAS = 1024, GLBK__CSM_CHUNK = 65536, GLBK__CSM_EXACT = 65536 };
#define GLBK__CSM_NONE 2.0f     /* a depth above 1: no hit */

static uint32_t glbk__csm_top(const glbk_csm_builder *b)
{
    return (1u << (b->desc.depth_bits ? b->desc.depth_bits : 8)) - 1u;
}

static uint32_t glbk__csm_layer_count(const glbk_csm_builder *b)
{
    return b->desc.layers == GLBK_CSM_LAYERS_Z1Z3_FAR ? 3 : 2;
}

static glbk_result glbk__csm_create_layers(glbk_context *ctx, glbk_csm_builder *b)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result;
    uint32_t i;

    memset(&texture, 0, sizeof texture);
    texture.format = GLBK_FORMAT_DEPTH32F;
    texture.width = texture.height = b->tiles * b->desc.map_size;
    result = glbk_texture_create(ctx, &texture, &b->depth);
    texture.format = GLBK_FORMAT_R32UI;
    for (i = 0; i < glbk__csm_layer_count(b) && result == GLBK_OK; i++) {
        memset(&target, 0, sizeof target);
        result = glbk_texture_create(ctx, &texture, &b->layers[i]);
        target.color[0] = &b->layers[i];
        target.depth = &b->depth;
        if (result == GLBK_OK) result = glbk_target_create(ctx, &target, &b->layer_targets[i]);
    }
    return result;
}

/* Where open segments and records go: two states to ping-pong between, or a buffer. */
static glbk_result glbk__csm_create_records(glbk_context *ctx, glbk_csm_builder *b)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result = GLBK_OK;
    size_t pixels = (size_t)b->desc.map_size * b->desc.map_size;
    int i, k;

    if (b->compute) return glbk_buffer_create(ctx, 64 * pixels, NULL, &b->storage);
    memset(&texture, 0, sizeof texture);
    texture.format = GLBK_FORMAT_RGBA32UI;
    texture.width = texture.height = b->desc.map_size;
    for (i = 0; i < 3 && result == GLBK_OK; i++) result = glbk_texture_create(ctx, &texture, &b->records[i]);
    for (i = 0; i < 2 && result == GLBK_OK; i++) {
        memset(&target, 0, sizeof target);
        result = glbk_texture_create(ctx, &texture, &b->opened[i]);
        target.color[0] = &b->opened[i];
        for (k = 0; k < 3; k++) target.color[k + 1] = &b->records[k];
        if (result == GLBK_OK) result = glbk_target_create(ctx, &target, &b->targets[i]);
    }
    return result;
}

/* Every pixel begins anew: all values possible, no view yet. Only the first words of the state are read back later. */
static void glbk__csm_open_all(glbk_csm_builder *b)
{
    size_t pixels = (size_t)b->desc.map_size * b->desc.map_size, i;
    memset(b->words, 0, 64 * pixels);
    for (i = 0; i < pixels; i++) {
        b->words[16 * i] = glbk__csm_top(b) << 8 | 65536u;
        b->firsts[i] = b->next_view;
    }
}

/* State to the GPU, with the cursors at the batch's first view. words: 16 a pixel, of which 4 are the state. */
static glbk_result glbk__csm_write_state(glbk_context *ctx, glbk_csm_builder *b)
{
    size_t pixels = (size_t)b->desc.map_size * b->desc.map_size, i;
    for (i = 0; i < pixels; i++) b->words[16 * i + 1] = b->words[16 * i + 2] = 0;
    if (b->compute) return glbk_buffer_update(ctx, &b->storage, 0, 64 * pixels, b->words);
    for (i = 1; i < pixels; i++) memmove(b->words + 4 * i, b->words + 16 * i, 16);
    return glbk_texture_update(ctx, &b->opened[b->now], 0, 0, 0, 0, b->desc.map_size, b->desc.map_size, 1, b->words);
}

/* State and records from the GPU, 16 words a pixel in either path. */
static glbk_result glbk__csm_read_state(glbk_context *ctx, glbk_csm_builder *b)
{
    uint32_t m = b->desc.map_size, k;
    size_t pixels = (size_t)m * m, i;
    uint32_t *planes = b->words + 16 * pixels;
    glbk_result result = GLBK_OK;

    if (b->compute) return glbk_buffer_read(ctx, &b->storage, 0, 64 * pixels, b->words);
    for (k = 0; k < 4 && result == GLBK_OK; k++) {
        result = glbk_target_read(ctx, &b->targets[b->now], k, 0, 0, m, m, planes);
        for (i = 0; i < pixels && result == GLBK_OK; i++) memcpy(b->words + 16 * i + 4 * k, planes + 4 * i, 16);
    }
    return result;
}

static int glbk__csm_keep(glbk_context *ctx, glbk_csm_builder *b, uint32_t pixel, uint32_t record, uint32_t end)
{
    glbk_csm_segment *s;
    if (b->segment_count == b->segment_room) {
        glbk__allocator memory = glbk__memory(ctx);
        size_t room = 2 * b->segment_room + 65536;
        s = (glbk_csm_segment *)glbk__alloc_array(&memory, room, sizeof *s);
        if (!s) return 0;
        if (b->segment_count) memcpy(s, b->segments, b->segment_count * sizeof *s);
        glbk__free(&memory, b->segments);
        b->segments = s;
        b->segment_room = room;
    }
    s = &b->segments[b->segment_count++];
    s->first = b->firsts[pixel];
    s->pixel = pixel;
    s->value = record & 0x1ffffu;
    b->firsts[pixel] = end;
    return 1;
}

GLBK_DEF glbk_result glbk_csm_builder_create(glbk_context *ctx, const glbk_csm_builder_desc *d, glbk_csm_builder *out)
{
    glbk__allocator memory;
    size_t pixels;
    glbk_result result;

    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!d || d->map_size < 4 || d->map_size > 1024 || (d->depth_bits && (d->depth_bits < 4 || d->depth_bits > 8)) ||
        !(d->open_thickness >= 0) || !glbk__finite(d->open_thickness) || !d->view_fn || !d->draw_fn ||
        (d->layers != GLBK_CSM_LAYERS_DEFAULT && d->layers != GLBK_CSM_LAYERS_Z1Z2 &&
         d->layers != GLBK_CSM_LAYERS_Z1Z3_FAR))
        return GLBK_ERR_ARGUMENT;
    out->desc = *d;
    pixels = (size_t)d->map_size * d->map_size;
    out->compute = ctx->compute && 64 * pixels <= ctx->max_storage;
    for (out->tiles = 8; out->tiles * d->map_size > GLBK__CSM_ATLAS; out->tiles /= 2) {}
    out->batch = out->tiles * out->tiles;       /* a power of two: batches end where csm.h's lists begin anew */
    memory = glbk__memory(ctx);
    out->words = (uint32_t *)glbk__alloc_array(&memory, pixels, 80);
    out->firsts = (uint32_t *)glbk__alloc_array(&memory, pixels, 4);
    result = out->words && out->firsts ? GLBK_OK : GLBK_ERR_ALLOC;
    if (result == GLBK_OK) result = glbk_program_create(ctx, "csm_peel.frag", "CSM_FIRST=1", &out->first_layer);
    if (result == GLBK_OK) result = glbk_program_create(ctx, "csm_peel.frag", "CSM_FIRST=0", &out->next_layer);
    if (result == GLBK_OK)
        result =
            glbk_program_create(ctx, out->compute ? "csm_compress.comp" : "csm_compress.frag", NULL, &out->compress);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_csm_peel), NULL, &out->block);
    if (result == GLBK_OK) result = glbk__csm_create_layers(ctx, out);
    if (result == GLBK_OK) result = glbk__csm_create_records(ctx, out);
    if (result == GLBK_OK) glbk__csm_open_all(out);
    else glbk_csm_builder_destroy(ctx, out);
    return result;
}

GLBK_DEF void glbk_csm_builder_destroy(glbk_context *ctx, glbk_csm_builder *b)
{
    int i;
    if (!b) return;
    glbk_program_destroy(ctx, &b->first_layer);
    glbk_program_destroy(ctx, &b->next_layer);
    glbk_program_destroy(ctx, &b->compress);
    for (i = 0; i < 3; i++) {
        glbk_target_destroy(ctx, &b->layer_targets[i]);
        glbk_texture_destroy(ctx, &b->layers[i]);
        glbk_texture_destroy(ctx, &b->records[i]);
    }
    for (i = 0; i < 2; i++) {
        glbk_target_destroy(ctx, &b->targets[i]);
        glbk_texture_destroy(ctx, &b->opened[i]);
    }
    glbk_texture_destroy(ctx, &b->depth);
    glbk_buffer_destroy(ctx, &b->block);
    glbk_buffer_destroy(ctx, &b->storage);
    if (ctx) {
        glbk__allocator memory = glbk__memory(ctx);
        glbk__free(&memory, b->words);
        glbk__free(&memory, b->firsts);
        glbk__free(&memory, b->segments);
    }
    memset(b, 0, sizeof *b);
}

static void glbk__csm_fill_block(const glbk_csm_builder *b, uint32_t views, glbk_csm_peel *out)
{
    float thickness = b->desc.open_thickness > 0 ? b->desc.open_thickness : 8.0f, m = (float)b->desc.map_size;
    memset(out, 0, sizeof *out);
    out->values[0] = 2.0f / m;
    out->values[2] = thickness * (b->desc.positional ? 2.0f : 65536.0f) / m;
    out->tiles[0] = b->desc.map_size;
    out->tiles[1] = b->tiles;
    out->tiles[2] = views;
    out->how[0] = glbk__csm_top(b);
    out->how[1] = b->desc.layers == GLBK_CSM_LAYERS_Z1Z3_FAR;
    out->how[2] = b->desc.positional != 0;
    out->how[3] = b->desc.self_only != 0;
}

GLBK_DEF glbk_result glbk_csm_builder_draw(glbk_context *ctx, glbk_csm_builder *b, uint32_t from, uint32_t count)
{
    static const float none[4] = { 1073741824.0f, 0, 0, 0 };    /* the bits of 2.0 as a number */
    glbk_csm_peel block;
    glbk_pass pass;
    glbk_csm_view view;
    glbk_result result = GLBK_OK;
    uint32_t layer, i, m;

    if (!ctx || !b || !b->block.name || !count || count > b->batch) return GLBK_ERR_ARGUMENT;
    m = b->desc.map_size;
    glbk__csm_fill_block(b, count, &block);
    memset(&pass, 0, sizeof pass);
    pass.depth = GLBK_DEPTH_LESS;
    for (layer = 0; layer < glbk__csm_layer_count(b); layer++) {
        pass.target = &b->layer_targets[layer];
        for (i = 0; i < count; i++) {
            b->desc.view_fn(b->desc.user, from + i, &view);
            memcpy(block.view, view.matrix, sizeof block.view);
            block.values[1] = view.depth_scale;
            result = glbk__put_block(ctx, GLBK_SLOT_glbk_csm_peel, &b->block, &block);
            if (result != GLBK_OK) return result;
            pass.viewport[0] = (int32_t)(i % b->tiles * m);
            pass.viewport[1] = (int32_t)(i / b->tiles * m);
            pass.viewport[2] = pass.viewport[3] = (int32_t)m;
            result = glbk_begin(ctx, &pass, layer ? &b->next_layer : &b->first_layer);
            if (result != GLBK_OK) return result;
            if (!i) {
                glbk_clear(ctx, pass.target, 0, none);
                glbk_clear_depth(ctx, 1);
            }
            if (layer) glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_layer1, &b->layers[layer - 1]);
            b->desc.draw_fn(b->desc.user, ctx);
        }
    }
    b->drawn = count;
    b->drawn_from = from;
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_builder_layers(glbk_context *ctx, glbk_csm_builder *b, uint32_t view, uint32_t layer,
                                             float *depths)
{
    uint32_t row[4 * 1024], m, x, y, at;
    glbk_result result = GLBK_OK;

    if (!ctx || !b || view < b->drawn_from || view - b->drawn_from >= b->drawn || !depths ||
        layer >= glbk__csm_layer_count(b))
        return GLBK_ERR_ARGUMENT;
    m = b->desc.map_size;
    at = view - b->drawn_from;
    for (y = 0; y < m && result == GLBK_OK; y++) {
        result =
            glbk_target_read(ctx, &b->layer_targets[layer], 0, at % b->tiles * m, at / b->tiles * m + y, m, 1, row);
        for (x = 0; x < m; x++) memcpy(depths + (size_t)y * m + x, row + 4 * x, 4);
    }
    return result;
}

/* One run of the shader, which goes on until each pixel is through or has no room for more records. */
static glbk_result glbk__csm_run_compress(glbk_context *ctx, glbk_csm_builder *b)
{
    glbk_pass pass;
    glbk_result result;
    uint32_t i, groups = (b->desc.map_size + 7) / 8;

    memset(&pass, 0, sizeof pass);
    pass.target = &b->targets[!b->now];
    if (!b->compute) {
        result = glbk_begin(ctx, &pass, &b->compress);
        if (result != GLBK_OK) return result;
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_opened, &b->opened[b->now]);
    }
    glbk_bind_block(ctx, GLBK_SLOT_glbk_csm_peel, &b->block);
    for (i = 0; i < 3; i++)         /* of two layers the third is not read */
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_layer0 + i, &b->layers[i]);
    b->passes++;
    if (b->compute) {
        glbk_bind_storage(ctx, GLBK_SLOT_glbk_csm_records, &b->storage);
        return glbk_dispatch(ctx, &b->compress, groups, groups, 1);
    }
    glbk_draw_screen(ctx);
    b->now = !b->now;
    return GLBK_OK;
}

/* Takes the records that a run left. *left: pixels that are not through. */
static glbk_result glbk__csm_take_records(glbk_context *ctx, glbk_csm_builder *b, size_t *left)
{
    uint32_t pixels = b->desc.map_size * b->desc.map_size, p, i;
    glbk_result result = glbk__csm_read_state(ctx, b);

    *left = 0;
    for (p = 0; p < pixels && result == GLBK_OK; p++) {
        const uint32_t *w = b->words + 16 * (size_t)p;
        for (i = 0; i < w[2] && i < 12; i++)
            if (!glbk__csm_keep(ctx, b, p, w[4 + i], b->next_view + (w[4 + i] >> 17))) return GLBK_ERR_ALLOC;
        *left += w[1] < b->drawn;
    }
    return result;
}

/* Lists of csm.h begin anew after 65,536 views: what is open ends there. */
static glbk_result glbk__csm_end_all(glbk_context *ctx, glbk_csm_builder *b)
{
    uint32_t pixels = b->desc.map_size * b->desc.map_size, p;
    for (p = 0; p < pixels; p++)
        if (b->firsts[p] != b->next_view &&
            !glbk__csm_keep(ctx, b, p, b->words[16 * (size_t)p] & 0xffffu, b->next_view))
            return GLBK_ERR_ALLOC;
    glbk__csm_open_all(b);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_builder_compress(glbk_context *ctx, glbk_csm_builder *b)
{
    glbk_csm_peel block;
    glbk_result result;
    size_t left = 1;

    if (!ctx || !b || !b->drawn || b->drawn_from != b->next_view ||
        b->next_view % GLBK__CSM_CHUNK + b->drawn > GLBK__CSM_CHUNK)
        return GLBK_ERR_ARGUMENT;
    glbk__csm_fill_block(b, b->drawn, &block);
    result = glbk_buffer_update(ctx, &b->block, 0, sizeof block, &block);
    if (result == GLBK_OK) result = glbk__csm_write_state(ctx, b);
    while (left && result == GLBK_OK) {
        result = glbk__csm_run_compress(ctx, b);
        if (result == GLBK_OK) result = glbk__csm_take_records(ctx, b, &left);
    }
    if (result != GLBK_OK) return result;
    b->next_view += b->drawn;
    b->drawn = 0;
    return b->next_view % GLBK__CSM_CHUNK == 0 ? glbk__csm_end_all(ctx, b) : GLBK_OK;
}

/* A depth of the builder's layers whose 16 bits are d <= 65533. */
static float glbk__csm_layer_depth(uint32_t d) { return d < 65533 ? ((float)d + 0.5f) / 65533.0f : 1.0f; }

/* Layers whose interval is just the values that the segment may have (lo .. hi on the grid, or one exact depth). */
static void glbk__csm_show(const glbk_csm_builder *b, uint32_t value, float *z1, float *z2, float *z3)
{
    uint32_t top = glbk__csm_top(b), lo = value & 255u, hi = value >> 8 & 255u;
    int far_layers = b->desc.layers == GLBK_CSM_LAYERS_Z1Z3_FAR;

    *z1 = *z2 = *z3 = GLBK__CSM_NONE;
    if (value & GLBK__CSM_EXACT) {              /* both layers in one place: an interval of that depth alone */
        *z1 = *z2 = *z3 = glbk__csm_layer_depth(value & 0xffffu);
        return;
    }
    if (lo == top || (b->desc.self_only && !lo && hi == top)) return;       /* nothing hit */
    *z1 = *z2 = glbk__csm_layer_depth(lo * 65535u / top);
    if (hi == top) return;                      /* FAR: no end */
    *(far_layers ? z3 : z2) = glbk__csm_layer_depth(hi * 65535u / top + 1u);
}

/* Segments in the order of their first views. */
static glbk_csm_segment *glbk__csm_by_view(const glbk__allocator *memory, const glbk_csm_builder *b, size_t *ends)
{
    glbk_csm_segment *sorted = (glbk_csm_segment *)glbk__alloc_array(memory, b->segment_count, sizeof *sorted);
    size_t i, sum = 0, n;
    if (!sorted) return NULL;
    memset(ends, 0, (size_t)b->next_view * sizeof *ends);
    for (i = 0; i < b->segment_count; i++) ends[b->segments[i].first]++;
    for (i = 0; i < b->next_view; i++) {
        n = ends[i];
        ends[i] = sum;
        sum += n;
    }
    for (i = 0; i < b->segment_count; i++) sorted[ends[b->segments[i].first]++] = b->segments[i];
    return sorted;
}

GLBK_DEF glbk_result glbk_csm_builder_replay(glbk_context *ctx, glbk_csm_builder *b,
                                             int (*add_fn)(void *user, uint32_t index, const float *z1, const float *z2,
                                                           const float *z3), void *user)
{
    glbk__allocator memory;
    glbk_csm_segment *sorted = NULL;
    size_t *ends, at = 0, pixels;
    float *z;
    uint32_t view;
    glbk_result result = GLBK_OK;

    if (!ctx || !b || !b->next_view || !add_fn) return GLBK_ERR_ARGUMENT;
    result = glbk__csm_end_all(ctx, b);
    if (result != GLBK_OK) return result;
    memory = glbk__memory(ctx);
    pixels = (size_t)b->desc.map_size * b->desc.map_size;
    z = (float *)glbk__alloc_array(&memory, 3 * pixels, sizeof *z);
    ends = (size_t *)glbk__alloc_array(&memory, b->next_view, sizeof *ends);
    if (z && ends) sorted = glbk__csm_by_view(&memory, b, ends);
    if (!sorted) result = GLBK_ERR_ALLOC;
    for (view = 0; view < b->next_view && result == GLBK_OK; view++) {
        for (; at < ends[view]; at++) {
            const glbk_csm_segment *s = &sorted[at];
            glbk__csm_show(b, s->value, z + s->pixel, z + pixels + s->pixel, z + 2 * pixels + s->pixel);
        }
        if (add_fn(user, view, z, z + pixels, z + 2 * pixels) != 0) result = GLBK_ERR_ARGUMENT;
    }
    glbk__free(&memory, sorted);
    glbk__free(&memory, ends);
    glbk__free(&memory, z);
    return result;
}

/* ---- >>sfield: fields and entities ---- */

enum {
    GLBK__SFIELD_HEADER = 32,
    GLBK__SFIELD_ENTITY = 7,
    GLBK__SFIELD_STAGE = 1024,          /* texels that go up together: of fields, once */
    GLBK__SFIELD_MOVING = 65536         /* and of what moves */
};

/* What a file says, its numbers looked at as far as sizes follow from them. */
typedef struct glbk__sfield_view {
    const uint8_t *bytes;
    uint32_t kind, bands, shells, side, spacing, frames, loop, channels, samples, stride, cells;
    size_t   scales, first, texels;             /* where they begin, bytes; texels that it becomes */
} glbk__sfield_view;

/* Texels on their way into a table. */
typedef struct glbk__sfield_stage {
    glbk_context *ctx;
    const glbk_texture *table;
    uint32_t *words;
    size_t    at, count, room;
    glbk_result result;
} glbk__sfield_stage;

static uint32_t glbk__sfield_word(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static float glbk__sfield_float(const uint8_t *p)
{
    uint32_t word = glbk__sfield_word(p);
    float x;
    memcpy(&x, &word, 4);
    return x;
}

static int glbk__sfield_open(const glbk_sfield_file *file, uint32_t bands, glbk__sfield_view *v)
{
    const uint8_t *p = (const uint8_t *)file->data;
    uint64_t planes = (bands * bands + 7) / 8 * 8, groups, most = (uint64_t)1 << 28;
    if (!p || file->size < 4 * GLBK__SFIELD_HEADER || file->size > 0xffffffffu) return 0;
    if (glbk__sfield_word(p) != 0x444c4653u || glbk__sfield_word(p + 4) != 1 ||
        glbk__sfield_word(p + 8) != file->size || glbk__sfield_word(p + 20) != 1 || glbk__sfield_word(p + 24) ||
        glbk__sfield_word(p + 28) != bands)
        return 0;
    v->bytes = p;
    v->bands = bands;
    v->kind = glbk__sfield_word(p + 16);
    v->shells = glbk__sfield_word(p + 36);
    v->side = glbk__sfield_word(p + 40);
    v->spacing = glbk__sfield_word(p + 44);
    v->frames = glbk__sfield_word(p + 48);
    v->loop = glbk__sfield_word(p + 52);
    v->channels = glbk__sfield_word(p + 56);
    v->samples = glbk__sfield_word(p + 60);
    v->stride = glbk__sfield_word(p + 64);
    if (v->kind > 1 || v->shells < 2 || v->shells > 64 || v->side < 2 || v->side > 64 || !v->frames ||
        v->frames > 256 || v->channels != (v->kind ? 3u : 1u) || v->stride != v->channels * planes)
        return 0;
    groups = (uint64_t)v->frames * v->shells;
    if (v->samples != groups * 6 * v->side * v->side) return 0;
    v->scales = 4 * (GLBK__SFIELD_HEADER + (size_t)v->shells);
    if (v->scales + 8 * groups * v->stride + (uint64_t)v->samples * v->stride != file->size) return 0;
    v->first = v->scales + 8 * (size_t)groups * v->stride;
    v->cells = (bands * bands + 15) / 16;
    if ((uint64_t)v->samples * v->channels * v->cells > most) return 0;
    v->texels = 3 + v->shells + ((size_t)groups * 8 + v->samples) * v->channels * v->cells;
    return glbk__sfield_float(p + 84) > 0;
}

static void glbk__sfield_flush(glbk__sfield_stage *s)
{
    if (s->count && s->result == GLBK_OK) s->result = glbk_table_update(s->ctx, s->table, s->at, s->count, s->words);
    s->at += s->count;
    s->count = 0;
}

static uint32_t *glbk__sfield_texel(glbk__sfield_stage *s)
{
    if (s->count == s->room) glbk__sfield_flush(s);
    return (uint32_t *)memset(s->words + 4 * s->count++, 0, 16);
}

/* The numbers of one channel and group: scale, or bias. */
static void glbk__sfield_put_floats(glbk__sfield_stage *s, const glbk__sfield_view *v, const uint8_t *from)
{
    uint32_t k, *texel = NULL;
    for (k = 0; k < 16 * v->cells; k++) {
        if (k % 4 == 0) texel = glbk__sfield_texel(s);
        if (k < v->bands * v->bands) texel[k % 4] = glbk__sfield_word(from + 4 * (size_t)k);
    }
}

/* lib/sfield_field.glsl's sfield_measure. */
static float glbk__sfield_measure(float d2, int source, int uniform)
{
    float inverse = 1 / d2, u = inverse < 1 ? inverse : 1;
    if (uniform) return -sqrtf(d2);
    return source || d2 < 1 ? inverse : u / (1 + sqrtf(1 - u));
}

static void glbk__sfield_put(glbk__sfield_stage *s, const glbk__sfield_view *v)
{
    const uint32_t step = v->stride / v->channels, groups = v->frames * v->shells;
    uint32_t *texel = glbk__sfield_texel(s), i, c, k;
    float pair[2];
    texel[0] = (v->kind ? 1u : 0u) | (v->spacing == 2 ? 2u : 0u) | (v->loop ? 4u : 0u);
    texel[1] = v->frames;
    texel[2] = v->shells;
    texel[3] = v->side;
    texel = glbk__sfield_texel(s);
    texel[0] = v->channels;
    texel[1] = 3 + v->shells;
    texel[2] = texel[1] + groups * v->channels * v->cells * 8;
    texel = glbk__sfield_texel(s);
    texel[0] = glbk__sfield_word(v->bytes + 92);
    for (i = 0; i < v->shells; i++) {
        pair[0] = glbk__sfield_float(v->bytes + 4 * (GLBK__SFIELD_HEADER + (size_t)i));
        pair[0] *= pair[0];
        pair[1] = glbk__sfield_measure(pair[0], v->kind == 1, v->spacing == 2);
        memcpy(glbk__sfield_texel(s), pair, sizeof pair);
    }
    for (i = 0; i < groups; i++)
        for (c = 0; c < v->channels; c++)
            for (k = 0; k < 2; k++)
                glbk__sfield_put_floats(s, v,
                                        v->bytes + v->scales + 4 * (((size_t)k * groups + i) * v->stride + c * step));
    for (i = 0; i < v->samples; i++)
        for (c = 0; c < v->channels; c++) {
            const uint8_t *from = v->bytes + v->first + (size_t)i * v->stride + c * step;
            for (k = 0; k < 16 * v->cells; k++) {
                if (k % 16 == 0) texel = glbk__sfield_texel(s);
                if (k < v->bands * v->bands) texel[k / 4 % 4] |= (uint32_t)from[k] << k % 4 * 8;
            }
        }
}

static void glbk__sfield_put_terms(glbk__sfield_stage *s, const glbk_sfield_desc *d)
{
    uint32_t i, *texel = NULL;
    for (i = 0; i < d->term_count; i++) {
        float c = d->factors[i];
        if ((d->terms[i] & 255u) == (d->terms[i] >> 8 & 255u)) c *= 0.5f;      /* a_i b_j + a_j b_i counts it twice */
        if (i % 2 == 0) texel = glbk__sfield_texel(s);
        texel[i % 2 * 2] = d->terms[i];
        memcpy(texel + i % 2 * 2 + 1, &c, 4);
    }
    for (i = (i + 1) / 2; i % 4; i++) (void)glbk__sfield_texel(s);      /* factor 0, to a multiple of 4 */
}

static uint32_t glbk__sfield_rotation_texels(uint32_t bands)
{
    uint32_t l, n = 0;
    for (l = 1; l < bands; l++) n += (2 * l + 1) * ((2 * l + 4) / 4);
    return n;
}

static int glbk__sfield_desc_valid(const glbk_sfield_desc *d)
{
    uint32_t i, n;
    if (!d || d->bands < 1 || d->bands > 8 || (d->file_count && !d->files) || !d->capacity || d->capacity > 65535 ||
        (d->term_count && (!d->terms || !d->factors)) || !(d->reach >= 0 && d->reach <= 1e6f) ||
        d->term_count > 1000000)
        return 0;
    n = d->bands * d->bands;
    for (i = 0; i < d->term_count; i++)
        if ((d->terms[i] & 255u) >= n || (d->terms[i] >> 8 & 255u) >= n || d->terms[i] >> 16 >= n) return 0;
    return 1;
}

static glbk_sfield_scene glbk__sfield_scene_of(const glbk_sfield_world *w, int sky)
{
    glbk_sfield_scene scene;
    memset(&scene, 0, sizeof scene);
    scene.table[0] = w->entities_at;
    scene.table[1] = w->count;
    scene.table[2] = w->lights;
    scene.table[3] = sky != 0;
    scene.parts[1] = w->terms;
    return scene;
}

static glbk_result glbk__sfield_tell(glbk_context *ctx, const glbk_sfield_world *w)
{
    const glbk_sfield_scene scene = glbk__sfield_scene_of(w, w->sky);
    return glbk_buffer_update(ctx, &w->scene, 0, sizeof scene, &scene);
}

static glbk_result glbk__sfield_create(glbk_context *ctx, const glbk_sfield_desc *d, glbk_sfield_field *fields,
                                       glbk__sfield_stage *s, glbk_sfield_world *out)
{
    glbk__sfield_view v;
    size_t texels, moving;
    uint32_t i, k;
    out->terms = (d->term_count + 7) / 8 * 4;
    out->entities_at = d->bands * d->bands;
    moving = out->entities_at +
             (size_t)d->capacity * (GLBK__SFIELD_ENTITY + glbk__sfield_rotation_texels(d->bands));
    if (moving > (size_t)1 << 28) return GLBK_ERR_LIMIT;
    texels = out->terms;
    for (i = 0; i < d->file_count; i++) {
        if (!glbk__sfield_open(&d->files[i], d->bands, &v)) return GLBK_ERR_ARGUMENT;
        fields[i].start = (uint32_t)texels;
        fields[i].source = v.kind == 1;
        for (k = 0; k < 3; k++) fields[i].center[k] = glbk__sfield_float(v.bytes + 72 + 4 * (size_t)k);
        fields[i].radius = glbk__sfield_float(v.bytes + 84);
        fields[i].inscribed = glbk__sfield_float(v.bytes + 88);
        fields[i].outer = glbk__sfield_float(v.bytes + 4 * (GLBK__SFIELD_HEADER + (size_t)v.shells) - 4);
        texels += v.texels;
        if (texels > (size_t)1 << 28) return GLBK_ERR_LIMIT;
    }
    out->texels = (uint32_t)texels;
    s->result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, texels + 1, &out->table);
    if (s->result == GLBK_OK)
        s->result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, moving, &out->moving);
    if (s->result == GLBK_OK) s->result = glbk_buffer_create(ctx, sizeof(glbk_sfield_scene), NULL, &out->scene);
    glbk__sfield_put_terms(s, d);
    for (i = 0; i < d->file_count; i++)
        if (glbk__sfield_open(&d->files[i], d->bands, &v)) glbk__sfield_put(s, &v);
    glbk__sfield_flush(s);
    s->table = &out->moving;
    s->at = 0;
    for (i = 0; i < out->entities_at; i++) (void)glbk__sfield_texel(s);         /* a black sky */
    glbk__sfield_flush(s);
    return s->result == GLBK_OK ? glbk__made(ctx, glbk__sfield_tell(ctx, out)) : s->result;
}

GLBK_DEF glbk_result glbk_sfield_create(glbk_context *ctx, const glbk_sfield_desc *d, glbk_sfield_field *fields,
                                        glbk_sfield_world *out)
{
    glbk__sfield_stage s;
    glbk__allocator memory;
    glbk_result result;

    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!glbk__sfield_desc_valid(d) || (d->file_count && !fields)) return GLBK_ERR_ARGUMENT;
    memory = glbk__memory(ctx);
    memset(&s, 0, sizeof s);
    s.ctx = ctx;
    s.table = &out->table;
    s.room = GLBK__SFIELD_STAGE;
    s.words = (uint32_t *)glbk__alloc(&memory, 16 * GLBK__SFIELD_STAGE);
    if (!s.words) return GLBK_ERR_ALLOC;
    out->bands = d->bands;
    out->capacity = d->capacity;
    out->reach = d->reach;
    result = glbk__sfield_create(ctx, d, fields, &s, out);
    glbk__free(&memory, s.words);
    if (result == GLBK_OK) return GLBK_OK;
    glbk_sfield_destroy(ctx, out);
    if (d->file_count) memset(fields, 0, d->file_count * sizeof *fields);
    return result;
}

GLBK_DEF void glbk_sfield_destroy(glbk_context *ctx, glbk_sfield_world *w)
{
    if (!w) return;
    glbk_texture_destroy(ctx, &w->table);
    glbk_texture_destroy(ctx, &w->moving);
    glbk_buffer_destroy(ctx, &w->scene);
    memset(w, 0, sizeof *w);
}

static int glbk__sfield_entity_valid(const glbk_sfield_world *w, const glbk_sfield_entity *e, float *scale)
{
    const float *m = e->transform;
    int k;
    if (!glbk__m4_is_rigid_uniform(m, scale)) return 0;
    if (!e->rotation && w->bands > 1 && (m[0] < 0 || m[5] < 0 || m[1] != 0 || m[2] != 0 || m[4] != 0 || m[6] != 0))
        return 0;
    for (k = 0; k < 3; k++)
        if (!(e->tint[k] >= -1e18f && e->tint[k] <= 1e18f)) return 0;
    return (!e->occlusion || (!e->occlusion->source && e->occlusion->start < w->texels)) &&
           (!e->source || (e->source->source && e->source->start < w->texels)) && e->time - e->time == 0;
}

static void glbk__sfield_sphere(const float *m, const glbk_sfield_field *f, float scale, float *out)
{
    glbk__v3_store(out, glbk__m4_point(m, glbk__v3_load(f->center)));
    out[3] = scale * f->radius;
}

static void glbk__sfield_entity_words(const glbk_sfield_world *w, const glbk_sfield_entity *e, float scale,
                                      uint32_t rotation, uint32_t *words)
{
    float f[4 * GLBK__SFIELD_ENTITY];
    uint32_t r, c;
    memset(f, 0, sizeof f);
    for (r = 0; r < 3; r++)
        for (c = 0; c < 3; c++) f[8 + 4 * r + c] = e->transform[4 * r + c] / scale;
    if (e->occlusion) {
        glbk__sfield_sphere(e->transform, e->occlusion, scale, f);
        f[11] = e->occlusion->inscribed * scale;
        f[15] = f[3];
        f[3] *= w->reach > 0 ? w->reach : e->occlusion->outer;
        f[3] *= f[3];
    }
    if (e->source) glbk__sfield_sphere(e->transform, e->source, scale, f + 4);
    f[19] = e->time;
    memcpy(f + 24, e->tint, 12);
    memcpy(words, f, sizeof f);
    words[20] = e->occlusion ? e->occlusion->start : GLBK_SFIELD_NONE;
    words[21] = e->source ? e->source->start : GLBK_SFIELD_NONE;
    words[22] = e->rotation && w->bands > 1 ? rotation : GLBK_SFIELD_NONE;
}

/* Rows filled up to a multiple of four; the first band does not turn. */
static void glbk__sfield_rotation(const float *block, uint32_t bands, glbk__sfield_stage *s)
{
    uint32_t l, y, x, n, *texel = NULL;
    for (l = 1, block++; l < bands; l++)
        for (y = 0, n = 2 * l + 1; y < n; y++)
            for (x = 0; x < n; x++) {
                if (x % 4 == 0) texel = glbk__sfield_texel(s);
                memcpy(texel + x % 4, block++, 4);
            }
}

GLBK_DEF glbk_result glbk_sfield_place(glbk_context *ctx, glbk_sfield_world *w, const glbk_sfield_entity *entities,
                                       uint32_t count)
{
    glbk__sfield_stage s;
    glbk__allocator memory;
    uint32_t i, step, lights = 0;
    size_t texels;
    float scale = 1;

    if (!ctx || !w || !w->table.name || count > w->capacity || (count && !entities)) return GLBK_ERR_ARGUMENT;
    for (i = 0; i < count; i++) {
        if (!glbk__sfield_entity_valid(w, &entities[i], &scale)) return GLBK_ERR_ARGUMENT;
        lights += entities[i].source != NULL;
    }
    memory = glbk__memory(ctx);
    memset(&s, 0, sizeof s);
    s.ctx = ctx;
    s.table = &w->moving;
    s.at = w->entities_at;
    step = glbk__sfield_rotation_texels(w->bands);
    texels = (size_t)count * (GLBK__SFIELD_ENTITY + step);
    s.room = texels < GLBK__SFIELD_MOVING ? texels : (size_t)GLBK__SFIELD_MOVING;
    s.words = (uint32_t *)glbk__alloc(&memory, 16 * (s.room + 1));
    if (!s.words) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i++) {
        uint32_t words[4 * GLBK__SFIELD_ENTITY], k;
        (void)glbk__m4_is_rigid_uniform(entities[i].transform, &scale);
        glbk__sfield_entity_words(w, &entities[i], scale, w->entities_at + GLBK__SFIELD_ENTITY * count + i * step,
                                  words);
        for (k = 0; k < GLBK__SFIELD_ENTITY; k++) memcpy(glbk__sfield_texel(&s), words + 4 * k, 16);
    }
    for (i = 0; i < count; i++)
        if (entities[i].rotation) glbk__sfield_rotation(entities[i].rotation, w->bands, &s);
        else {
            uint32_t k;
            for (k = 0; k < step; k++) (void)glbk__sfield_texel(&s);
        }
    glbk__sfield_flush(&s);
    glbk__free(&memory, s.words);
    if (s.result != GLBK_OK) return s.result;
    w->count = count;
    w->lights = lights;
    return glbk__sfield_tell(ctx, w);
}

GLBK_DEF glbk_result glbk_sfield_sky(glbk_context *ctx, glbk_sfield_world *w, const float *coefs)
{
    uint32_t words[4 * 64] = { 0 }, n, k, c;
    glbk_result result;
    if (!ctx || !w || !w->table.name) return GLBK_ERR_ARGUMENT;
    n = w->bands * w->bands;
    for (k = 0; k < n && coefs; k++)
        for (c = 0; c < 3; c++) memcpy(&words[4 * k + c], &coefs[c * n + k], 4);
    result = glbk_table_update(ctx, &w->moving, 0, n, words);
    if (result != GLBK_OK) return result;
    w->sky = coefs != NULL;
    return glbk__sfield_tell(ctx, w);
}

GLBK_DEF void glbk_sfield_bind(glbk_context *ctx, const glbk_sfield_world *w)
{
    if (!w) return;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_table, &w->table);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_moving, &w->moving);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_sfield_scene, &w->scene);
}

/* ---- >>sfield: the renderer ---- */

static glbk_result glbk__sfield_textures(glbk_context *ctx, glbk_sfield_renderer *r, int gloss)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result;

    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    texture.width = r->width;
    texture.height = r->height;
    texture.format = GLBK_FORMAT_COLOR;
    result = glbk_texture_create(ctx, &texture, &r->light);
    target.color[0] = &r->light;
    if (gloss && result == GLBK_OK) {
        result = glbk_texture_create(ctx, &texture, &r->gloss);
        target.color[1] = &r->gloss;
    }
    if (result == GLBK_OK) result = glbk_target_create(ctx, &target, &r->target);
    texture.format = GLBK_FORMAT_RGBA32UI;
    if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &r->place);
    if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &r->normal);
    texture.layers = (r->bands * r->bands + 7) / 8;
    if (texture.layers < 2) texture.layers = 2;         /* what a drawn G-buffer has */
    if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &r->self);
    return result;
}

static glbk_result glbk__sfield_drawn(glbk_context *ctx, glbk_sfield_renderer *r)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result;

    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    texture.width = r->width;
    texture.height = r->height;
    texture.format = GLBK_FORMAT_DEPTH32F;
    result = glbk_texture_create(ctx, &texture, &r->depth);
    target.color[0] = &r->place;
    target.color[1] = &r->normal;
    target.color[2] = target.color[3] = &r->self;
    target.layer[3] = 1;
    target.depth = &r->depth;
    if (result == GLBK_OK) result = glbk_target_create(ctx, &target, &r->gbuffer_target);
    if (result == GLBK_OK) result = glbk_program_create(ctx, "sfield_gbuffer.frag", NULL, &r->fill);
    return result;
}

static void glbk__sfield_number(glbk__sink *sink, uint32_t n)
{
    char digits[12];
    size_t at = sizeof digits;
    do digits[--at] = (char)('0' + n % 10);
    while ((n /= 10) != 0);
    glbk__put(sink, digits + at, sizeof digits - at);
}

static void glbk__sfield_index(glbk__sink *sink, const char *array, uint32_t n)
{
    glbk__put_text(sink, array);
    glbk__put_text(sink, "[");
    glbk__sfield_number(sink, n);
    glbk__put_text(sink, "]");
}

static void glbk__sfield_pair(glbk__sink *sink, uint32_t i, uint32_t j)
{
    glbk__sfield_index(sink, "(a", i);
    glbk__sfield_index(sink, "*b", j);
    if (i != j) {
        glbk__sfield_index(sink, "+a", j);
        glbk__sfield_index(sink, "*b", i);
    }
    glbk__put_text(sink, ")");
}

GLBK_DEF size_t glbk_sfield_write_product(uint32_t bands, const uint32_t *terms, const float *factors, uint32_t count,
                                          char *out, size_t size)
{
    static const char head[] = "void sfield_product(uvec2 terms, float a[SFIELD_COEFS], float b[SFIELD_COEFS], "
                               "out float r[SFIELD_COEFS])\n{\nfloat s=0.0;\n";
    glbk__sink sink;
    uint32_t k, e;

    if (bands < 1 || bands > 8 || (count && (!terms || !factors))) return 0;
    sink.out = out;
    sink.size = out ? size : 0;
    sink.used = 0;
    glbk__put_text(&sink, head);
    for (k = 0; k < bands * bands; k++) {
        glbk__sfield_index(&sink, "s+=a", k);
        glbk__sfield_index(&sink, "*b", k);
        glbk__put_text(&sink, ";\n");
        if (!k) continue;
        glbk__sfield_index(&sink, "r", k);
        glbk__put_text(&sink, "=SFIELD_Y00*");
        glbk__sfield_pair(&sink, 0, k);
        for (e = 0; e < count; e++) {
            uint32_t bits;
            if (terms[e] >> 16 != k) continue;
            memcpy(&bits, &factors[e], 4);      /* the float itself, whatever the locale */
            glbk__put_text(&sink, "\n+uintBitsToFloat(");
            glbk__sfield_number(&sink, bits);
            glbk__put_text(&sink, "u)*");
            glbk__sfield_pair(&sink, terms[e] & 255u, terms[e] >> 8 & 255u);
        }
        glbk__put_text(&sink, ";\n");
    }
    glbk__put_text(&sink, "r[0]=SFIELD_Y00*s;\n}\n");
    if (sink.size) out[sink.used < sink.size ? sink.used : sink.size - 1] = 0;
    return sink.used + 1;
}

/* The pass's program with the product written out: it goes behind sfield_field and before what calls it. */
static glbk_result glbk__sfield_compile(glbk_context *ctx, const glbk_sfield_renderer_desc *d, const char *defines,
                                        int compute, glbk_program *out)
{
    const char *const names[] = { "lib/sfield_shade.glsl", "lib/sfield_gbuffer.glsl",
                                  compute ? "prog/sfield_shade.comp" : "prog/sfield_shade.frag" };
    glbk__allocator memory = glbk__memory(ctx);
    size_t product = glbk_sfield_write_product(d->bands, d->terms, d->factors, d->term_count, NULL, 0);
    glbk_source source;
    glbk__sink sink;
    glbk_result result;
    uint32_t i, k;

    for (i = 0, sink.size = product; i < 3; i++)
        for (k = 0; k < glbk_find_file(names[i])->line_count; k++)
            sink.size += strlen(glbk_find_file(names[i])->lines[k]);
    sink.out = (char *)glbk__alloc(&memory, sink.size);
    if (!sink.out) return GLBK_ERR_ALLOC;
    glbk_sfield_write_product(d->bands, d->terms, d->factors, d->term_count, sink.out, sink.size);
    sink.used = product - 1;
    for (i = 0; i < 3; i++) glbk__put_file(&sink, glbk_find_file(names[i]));
    sink.out[sink.used] = 0;
    memset(&source, 0, sizeof source);
    *(compute ? &source.compute : &source.fragment) = sink.out;
    source.uses = compute ? "sfield_list sfield_field" : "sfield_access sfield_field";
    source.defines = defines;
    result = glbk_program_compile(ctx, &source, out);
    glbk__free(&memory, sink.out);
    return result;
}

GLBK_DEF glbk_result glbk_sfield_renderer_create(glbk_context *ctx, const glbk_sfield_renderer_desc *d,
                                                 glbk_sfield_renderer *out)
{
    char defines[] = "SFIELD_BANDS=4 SFIELD_GLOSS=0 SFIELD_UNROLLED";
    int unrolled;
    glbk_result result;

    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!d || !d->width || !d->height || d->bands < 1 || d->bands > 8 || (d->term_count && (!d->terms || !d->factors)))
        return GLBK_ERR_ARGUMENT;
    unrolled = (d->term_count || d->bands == 1) && d->bands < 5;
    if (!unrolled) defines[29] = 0;
    out->width = d->width;
    out->height = d->height;
    out->bands = d->bands;
    out->compute = ctx->compute;
    defines[13] = (char)('0' + d->bands);
    defines[28] = d->gloss ? '1' : '0';
    result = glbk__sfield_textures(ctx, out, d->gloss);
    if (result == GLBK_OK && d->bands <= 4) result = glbk__sfield_drawn(ctx, out);
    if (result == GLBK_OK)
        result = unrolled ? glbk__sfield_compile(ctx, d, defines, out->compute, &out->shade)
                          : glbk_program_create(ctx, out->compute ? "sfield_shade.comp" : "sfield_shade.frag", defines,
                                                &out->shade);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_sfield_frame), NULL, &out->frame);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_sfield_object), NULL, &out->object);
    if (result != GLBK_OK) glbk_sfield_renderer_destroy(ctx, out);
    return result;
}

GLBK_DEF void glbk_sfield_renderer_destroy(glbk_context *ctx, glbk_sfield_renderer *r)
{
    if (!r) return;
    glbk_program_destroy(ctx, &r->shade);
    glbk_program_destroy(ctx, &r->fill);
    glbk_target_destroy(ctx, &r->target);
    glbk_target_destroy(ctx, &r->gbuffer_target);
    glbk_texture_destroy(ctx, &r->light);
    glbk_texture_destroy(ctx, &r->gloss);
    glbk_texture_destroy(ctx, &r->place);
    glbk_texture_destroy(ctx, &r->normal);
    glbk_texture_destroy(ctx, &r->self);
    glbk_texture_destroy(ctx, &r->depth);
    glbk_buffer_destroy(ctx, &r->frame);
    glbk_buffer_destroy(ctx, &r->object);
    memset(r, 0, sizeof *r);
}

/* Signed 16 bits, 32767 for 1.5: the norm of what is at most a cosine is 1.45. */
static uint32_t glbk__sfield_short(float x)
{
    x = x * (1 / 1.5f);
    x = x > -1 ? (x < 1 ? x : 1) : -1;
    return (uint32_t)(int32_t)(x * 32767 + (x < 0 ? -0.5f : 0.5f)) & 0xffffu;
}

GLBK_DEF glbk_result glbk_sfield_upload(glbk_context *ctx, glbk_sfield_renderer *r, uint32_t row, uint32_t rows,
                                        const glbk_sfield_pixel *pixels)
{
    glbk__allocator memory;
    uint32_t *words, layer, k, n;
    size_t count, i;
    glbk_result result;

    if (!ctx || !r || !r->place.name || !rows || row >= r->height || rows > r->height - row || !pixels)
        return GLBK_ERR_ARGUMENT;
    memory = glbk__memory(ctx);
    count = (size_t)r->width * rows;
    n = r->bands * r->bands;
    words = (uint32_t *)glbk__alloc_array(&memory, count, 32);
    if (!words) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i++) {
        uint32_t *place = words + 4 * i, *normal = words + 4 * (count + i);
        memcpy(place, pixels[i].position, 12);
        place[3] = pixels[i].entity;
        memcpy(normal, pixels[i].normal, 12);
        memcpy(normal + 3, &pixels[i].exponent, 4);
        normal[3] = (normal[3] & 0x7fffffffu) | (pixels[i].self ? 0x80000000u : 0u);
    }
    result = glbk_texture_update(ctx, &r->place, 0, 0, row, 0, r->width, rows, 1, words);
    if (result == GLBK_OK)
        result = glbk_texture_update(ctx, &r->normal, 0, 0, row, 0, r->width, rows, 1, words + 4 * count);
    for (layer = 0; 8 * layer < n && result == GLBK_OK; layer++) {
        memset(words, 0, 16 * count);
        for (i = 0; i < count; i++)
            for (k = 0; k < 8 && 8 * layer + k < n && pixels[i].self; k++)
                words[4 * i + k / 2] |= glbk__sfield_short(pixels[i].self[8 * layer + k]) << k % 2 * 16;
        result = glbk_texture_update(ctx, &r->self, 0, 0, row, layer, r->width, rows, 1, words);
    }
    glbk__free(&memory, words);
    return result;
}

GLBK_DEF glbk_result glbk_sfield_gbuffer_begin(glbk_context *ctx, glbk_sfield_renderer *r)
{
    static const float zero[4] = { 0, 0, 0, 0 };
    glbk_pass pass;
    glbk_result result;
    uint32_t i;

    if (!ctx || !r || !r->place.name) return GLBK_ERR_ARGUMENT;
    if (!r->fill.name) return GLBK_ERR_LIMIT;
    memset(&pass, 0, sizeof pass);
    pass.target = &r->gbuffer_target;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_begin(ctx, &pass, &r->fill);
    if (result != GLBK_OK) return result;
    for (i = 0; i < 4; i++) glbk_clear(ctx, &r->gbuffer_target, i, zero);
    glbk_clear_depth(ctx, 1);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_sfield_gbuffer_object(glbk_context *ctx, glbk_sfield_renderer *r, const glbk_sfield_draw *d)
{
    glbk_sfield_object object;

    if (!ctx || !r || !r->fill.name || !d || !(d->exponent >= 0)) return GLBK_ERR_ARGUMENT;
    memset(&object, 0, sizeof object);
    memcpy(object.world, d->world, sizeof object.world);
    memcpy(object.clip, d->clip, sizeof object.clip);
    object.kinds[0] = d->entity;
    object.kinds[1] = d->recorded != 0;
    object.gloss[0] = d->exponent;
    return glbk__put_block(ctx, GLBK_SLOT_glbk_sfield_object, &r->object, &object);
}

GLBK_DEF glbk_result glbk_sfield_shade(glbk_context *ctx, glbk_sfield_renderer *r, const glbk_sfield_world *w,
                                       const float eye[3], int open)
{
    glbk_sfield_frame frame;
    glbk_sfield_scene scene;
    glbk_pass pass;
    glbk_result result;

    if (!ctx || !r || !r->shade.name || !w || !w->table.name || w->bands != r->bands || (r->gloss.name && !eye))
        return GLBK_ERR_ARGUMENT;
    memset(&frame, 0, sizeof frame);
    memset(&pass, 0, sizeof pass);
    if (eye) memcpy(frame.eye, eye, 12);
    scene = glbk__sfield_scene_of(w, w->sky || open);
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_sfield_frame, &r->frame, &frame);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_sfield_scene, &w->scene, &scene);
    pass.target = &r->target;
    if (result == GLBK_OK && !r->compute) result = glbk_begin(ctx, &pass, &r->shade);
    if (result != GLBK_OK) return result;
    glbk_sfield_bind(ctx, w);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_place, &r->place);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_normal, &r->normal);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_self, &r->self);
    if (r->compute) {
        glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_light_image, &r->light);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_gloss_image, &r->gloss);
        return glbk_dispatch(ctx, &r->shade, (r->width + 7) / 8, (r->height + 7) / 8, 1);
    }
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_sfield_read(glbk_context *ctx, glbk_sfield_renderer *r, float *light, float *gloss)
{
    glbk_result result = GLBK_OK;
    if (!ctx || !r || !r->target.name || (gloss && !r->gloss.name)) return GLBK_ERR_ARGUMENT;
    if (light) result = glbk_target_read(ctx, &r->target, 0, 0, 0, r->width, r->height, light);
    if (gloss && result == GLBK_OK) result = glbk_target_read(ctx, &r->target, 1, 0, 0, r->width, r->height, gloss);
    return result;
}

/* ---- >>sfield: building ---- */

enum { GLBK__SFIELD_TILES = 256, GLBK__SFIELD_BATCH = 128 };

/* Floats of an eye's values, of one channel. */
static size_t glbk__sfield_values(const glbk_sfield_builder *b)
{
    return b->bands ? (size_t)b->bands * b->bands : (size_t)6 * b->side * b->side;
}

static const float *glbk__sfield_vertex(const glbk_sfield_builder_desc *d, size_t i)
{
    size_t stride = d->vertex_stride ? d->vertex_stride : 12;
    return (const float *)(const void *)((const char *)(const void *)d->positions + i * stride);
}

/* Corners of triangle t, whose indices are in range; 0 where sfield_build would skip it. */
static int glbk__sfield_corners(const glbk_sfield_builder_desc *d, size_t t, uint32_t corner[3])
{
    int i, k;
    for (i = 0; i < 3; i++) {
        const float *p;
        corner[i] = d->indices ? d->indices[3 * t + (size_t)i] : (uint32_t)(3 * t) + (uint32_t)i;
        p = glbk__sfield_vertex(d, corner[i]);
        for (k = 0; k < 3; k++)
            if (!(fabsf(p[k]) < 1e18f)) return 0;
    }
    return 1;
}

/* The sphere that faces are chosen by; 0 where no triangle is left. */
static int glbk__sfield_fit(const glbk_sfield_builder_desc *d, size_t triangles, glbk_sfield_builder *b)
{
    float low[3] = { 2e18f, 2e18f, 2e18f }, high[3] = { -2e18f, -2e18f, -2e18f }, r2 = 0;
    uint32_t corner[3];
    size_t t;
    int pass, i, k;
    for (pass = 0; pass < 2; pass++) {
        for (t = 0; t < triangles; t++) {
            if (!glbk__sfield_corners(d, t, corner)) continue;
            for (i = 0; i < 3; i++) {
                const float *p = glbk__sfield_vertex(d, corner[i]);
                float sum = 0;
                for (k = 0; k < 3; k++) {
                    low[k] = p[k] < low[k] ? p[k] : low[k];
                    high[k] = p[k] > high[k] ? p[k] : high[k];
                    sum += (p[k] - b->center[k]) * (p[k] - b->center[k]);
                }
                r2 = pass && sum > r2 ? sum : r2;
            }
        }
        for (k = 0; k < 3; k++) b->center[k] = 0.5f * low[k] + 0.5f * high[k];
    }
    b->radius = sqrtf(r2);
    return low[0] <= high[0];
}

/* Vertices and the indices of good triangles; sources: three corners with their radiance for each. */
static glbk_result glbk__sfield_upload_mesh(glbk_context *ctx, const glbk_sfield_builder_desc *d, size_t triangles,
                                            glbk_sfield_builder *b)
{
    glbk__allocator memory = glbk__memory(ctx);
    size_t vertices = d->source ? 3 * triangles : d->vertex_count, floats = d->source ? 6 : 3, t, i, n = 0;
    float *vertex = (float *)glbk__alloc_array(&memory, vertices, floats * sizeof *vertex), *v = vertex;
    uint32_t *index = (uint32_t *)glbk__alloc_array(&memory, triangles, 3 * sizeof *index), corner[3];
    glbk_result result = vertex && index ? GLBK_OK : GLBK_ERR_ALLOC;

    for (i = 0; i < vertices && !d->source && result == GLBK_OK; i++)
        memcpy(vertex + 3 * i, glbk__sfield_vertex(d, i), 12);
    for (t = 0; t < triangles && result == GLBK_OK; t++) {
        if (!glbk__sfield_corners(d, t, corner)) continue;
        for (i = 0; i < 3; i++, n++) {
            index[n] = d->source ? (uint32_t)n : corner[i];
            if (!d->source) continue;
            memcpy(v, glbk__sfield_vertex(d, corner[i]), 12);
            memcpy(v + 3, d->radiance + 3 * t, 12);
            v += 6;
        }
    }
    b->index_count = (uint32_t)n;
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, vertices * floats * sizeof *vertex, vertex, &b->vertices);
    if (result == GLBK_OK) result = glbk_indices_create(ctx, n * sizeof *index, index, &b->indices);
    glbk__free(&memory, vertex);
    glbk__free(&memory, index);
    return result;
}

static glbk_result glbk__sfield_vertex_array(glbk_context *ctx, glbk_sfield_builder *b)
{
    int32_t array = 0, buffer = 0, stride = b->source ? 24 : 12;
    glbk_result result = glbk__enter(ctx);

    if (result != GLBK_OK) return result;
    ctx->gl.GetIntegerv(0x85B5 /* VERTEX_ARRAY_BINDING */, &array);
    ctx->gl.GetIntegerv(0x8894 /* ARRAY_BUFFER_BINDING */, &buffer);
    ctx->gl.GenVertexArrays(1, &b->vertex_array);
    ctx->gl.BindVertexArray(b->vertex_array);
    ctx->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, b->vertices.name);
    ctx->gl.BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, b->indices.name);
    ctx->gl.EnableVertexAttribArray(0);
    ctx->gl.VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, stride, NULL);
    if (b->source) {
        ctx->gl.EnableVertexAttribArray(1);
        ctx->gl.VertexAttribPointer(1, 3, GLBK_GL_FLOAT, 0, stride, (const void *)(size_t)12);
    }
    ctx->gl.BindVertexArray((uint32_t)array);
    ctx->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, (uint32_t)buffer);
    return glbk__leave(ctx);
}

static glbk_result glbk__sfield_take_mesh(glbk_context *ctx, const glbk_sfield_builder_desc *d, glbk_sfield_builder *b)
{
    size_t corners = d->indices ? d->index_count : d->vertex_count, i;
    glbk_result result;

    if (!corners || corners % 3 || corners > 0x7fffffffu || d->vertex_count > 0xffffffffu ||
        (d->vertex_stride && (d->vertex_stride < 12 || d->vertex_stride % 4)) || (d->source && !d->radiance))
        return GLBK_ERR_ARGUMENT;
    for (i = 0; i < corners && d->indices; i++)
        if (d->indices[i] >= d->vertex_count) return GLBK_ERR_ARGUMENT;
    for (i = 0; i < corners && d->source; i++)
        if (!(d->radiance[i] >= 0 && d->radiance[i] <= 1e18f)) return GLBK_ERR_ARGUMENT;
    if (!glbk__sfield_fit(d, corners / 3, b)) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_upload_mesh(ctx, d, corners / 3, b);
    return result == GLBK_OK ? glbk__sfield_vertex_array(ctx, b) : result;
}

/* Where texel (face, x, y) of a cube stands in shadowfield.h's order. */
static uint32_t glbk__sfield_morton(uint32_t side, uint32_t face, uint32_t x, uint32_t y)
{
    uint32_t morton = 0, bit;
    for (bit = 0; bit < 6; bit++) morton |= (x >> bit & 1u) << 2 * bit | (y >> bit & 1u) << (2 * bit + 1);
    return face * side * side + morton;
}

/* Groups of four coefficients, for each of them all texels in rows as the cubes have them. */
static glbk_result glbk__sfield_upload_basis(glbk_context *ctx, const float *basis, glbk_sfield_builder *b)
{
    glbk__allocator memory = glbk__memory(ctx);
    const uint32_t n = b->bands * b->bands, side = b->side, cells = 6 * side * side;
    float *table = (float *)glbk__alloc_array(&memory, (size_t)cells * b->groups, 16);
    uint32_t face, x, y, k;
    glbk_result result;

    if (!table) return GLBK_ERR_ALLOC;
    memset(table, 0, (size_t)cells * b->groups * 16);
    for (y = 0; y < side; y++)
        for (face = 0; face < 6; face++)
            for (x = 0; x < side; x++) {
                size_t at = (size_t)y * 6 * side + face * side + x;
                const float *from = basis + (size_t)glbk__sfield_morton(side, face, x, y) * n;
                for (k = 0; k < n; k++) table[4 * (at + (size_t)(k / 4) * cells) + k % 4] = from[k];
            }
    result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, table, (size_t)cells * b->groups, &b->basis);
    glbk__free(&memory, table);
    return result;
}

static glbk_result glbk__sfield_canvases(glbk_context *ctx, glbk_sfield_builder *b)
{
    const uint32_t size = !b->source && ctx->max_size >= 2048 ? 2048u : 1024u, channels = b->source ? 3 : 1;
    glbk_texture_desc depth;
    glbk_result result = GLBK_OK;

    memset(&depth, 0, sizeof depth);
    depth.format = GLBK_FORMAT_DEPTH32F;
    depth.width = depth.height = b->height = size;
    if (b->source) result = glbk_texture_create(ctx, &depth, &b->depth);
    if (result == GLBK_OK)
        result = glbk__canvas(ctx, b->source ? GLBK_FORMAT_RGBA32UI : GLBK_FORMAT_R8UI, size, size,
                              b->source ? &b->depth : NULL, &b->seen, &b->seen_target);
    b->batch = (ctx->max_size >= 2048 ? 2048 : 1024) / b->side;
    b->batch = b->batch < GLBK__SFIELD_BATCH ? b->batch : (uint32_t)GLBK__SFIELD_BATCH;
    if (result == GLBK_OK)
        result = glbk__canvas(ctx, GLBK_FORMAT_RGBA32UI, 6 * b->side / (b->source ? 1 : 4),
                              b->batch * b->side, NULL, &b->cube, &b->cube_target);
    if (result == GLBK_OK && b->bands)
        result = glbk__canvas(ctx, GLBK_FORMAT_RGBA32UI, b->groups * channels, b->batch, NULL, &b->coefs,
                              &b->coef_target);
    return result;
}

GLBK_DEF glbk_result glbk_sfield_builder_create(glbk_context *ctx, const glbk_sfield_builder_desc *d,
                                                glbk_sfield_builder *out)
{
    char defines[] = "SFIELD_SOURCE=0 SFIELD_BANDS=0";
    glbk__allocator memory;
    glbk_result result = GLBK_OK;

    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!d || d->cube_side < 4 || d->cube_side > 64 || (d->cube_side & (d->cube_side - 1)) || d->bands > 8 ||
        (d->bands && !d->basis) || (!d->positions && !d->draw_fn))
        return GLBK_ERR_ARGUMENT;
    out->side = d->cube_side;
    out->bands = d->bands;
    out->groups = (d->bands * d->bands + 3) / 4;
    out->source = d->source != 0;
    out->draw_fn = d->positions ? NULL : d->draw_fn;
    out->user = d->user;
    out->compute = ctx->compute;
    defines[14] = out->source ? '1' : '0';
    defines[29] = (char)('0' + d->bands);
    if (d->positions) result = glbk__sfield_take_mesh(ctx, d, out);
    if (result == GLBK_OK && d->bands) result = glbk__sfield_upload_basis(ctx, d->basis, out);
    if (result == GLBK_OK) result = glbk__sfield_canvases(ctx, out);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_sfield_views), NULL, &out->block);
    if (result == GLBK_OK) result = glbk_program_create(ctx, "sfield_see.frag", defines, &out->see);
    if (result == GLBK_OK)
        result = glbk_program_create(ctx, out->compute ? "sfield_sum.comp" : "sfield_sum.frag", defines, &out->sum);
    if (result == GLBK_OK && d->bands)
        result = glbk_program_create(ctx, out->compute ? "sfield_project.comp" : "sfield_project.frag", defines,
                                     &out->project);
    if (result == GLBK_OK) {
        const glbk_texture *last = d->bands ? &out->coefs : &out->cube;
        memory = glbk__memory(ctx);
        out->views = (glbk_sfield_views *)glbk__alloc(&memory, sizeof *out->views);
        out->words = (uint32_t *)glbk__alloc_array(&memory, (size_t)last->width * last->height, 16);
        if (!out->views || !out->words) result = GLBK_ERR_ALLOC;
    }
    if (result != GLBK_OK) glbk_sfield_builder_destroy(ctx, out);
    return result;
}

GLBK_DEF void glbk_sfield_builder_destroy(glbk_context *ctx, glbk_sfield_builder *b)
{
    if (!b) return;
    if (ctx && !ctx->lost && b->vertex_array) ctx->gl.DeleteVertexArrays(1, &b->vertex_array);
    glbk_buffer_destroy(ctx, &b->vertices);
    glbk_buffer_destroy(ctx, &b->indices);
    glbk_buffer_destroy(ctx, &b->block);
    glbk_target_destroy(ctx, &b->seen_target);
    glbk_target_destroy(ctx, &b->cube_target);
    glbk_target_destroy(ctx, &b->coef_target);
    glbk_texture_destroy(ctx, &b->seen);
    glbk_texture_destroy(ctx, &b->depth);
    glbk_texture_destroy(ctx, &b->cube);
    glbk_texture_destroy(ctx, &b->coefs);
    glbk_texture_destroy(ctx, &b->basis);
    glbk_program_destroy(ctx, &b->see);
    glbk_program_destroy(ctx, &b->sum);
    glbk_program_destroy(ctx, &b->project);
    if (ctx) {
        glbk__allocator memory = glbk__memory(ctx);
        glbk__free(&memory, b->views);
        glbk__free(&memory, b->words);
    }
    memset(b, 0, sizeof *b);
}

/* Samples a side of a face from an eye at distance d: what sfield_build takes. */
static uint32_t glbk__sfield_width(const glbk_sfield_builder *b, const float *eye)
{
    float d = sqrtf(eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2]);
    uint32_t most = b->source ? 256 : 512, width;
    if (most > 64 * b->side) most = 64 * b->side;
    for (width = 64; width < most && ((float)width < 24 * d || width < 2 * b->side);) width *= 2;
    return width;
}

/* Does the sphere (center in radii from the eye) reach into the pyramid of a face? Rather yes. */
static int glbk__sfield_faces(const float *center, float radius, uint32_t face)
{
    uint32_t axis = face / 2, k;
    float along = face % 2 ? -center[axis] : center[axis], reach = 1.001f * radius * 1.41421356f;
    if (along < -1.001f * radius) return 0;
    for (k = 0; k < 3; k++)
        if (k != axis && fabsf(center[k]) - along > reach) return 0;
    return 1;
}

/* One atlas: its tiles are drawn column by column, and counted into the cubes. */
static glbk_result glbk__sfield_draw_tiles(glbk_context *ctx, glbk_sfield_builder *b, uint32_t tiles)
{
    static const float none[4] = { 0, 0, 0, 0 };
    const uint32_t width = b->views->how[2], rows = b->views->how[1];
    glbk_pass pass;
    glbk_result result;
    uint32_t first;

    memset(&pass, 0, sizeof pass);
    pass.target = &b->seen_target;
    pass.depth = b->source ? GLBK_DEPTH_LESS : GLBK_DEPTH_OFF;
    pass.viewport[2] = (int32_t)width;
    pass.viewport[3] = (int32_t)(rows * width);
    for (first = 0; first < tiles; first += rows) {
        const int32_t count = (int32_t)(tiles - first < rows ? tiles - first : rows);
        b->views->how[0] = first;
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_sfield_views, &b->block, b->views);
        pass.viewport[0] = (int32_t)(first / rows * width);
        if (result == GLBK_OK) result = glbk_begin(ctx, &pass, &b->see);
        if (result != GLBK_OK) return result;
        if (!first) {
            glbk_clear(ctx, &b->seen_target, 0, none);
            if (b->source) glbk_clear_depth(ctx, 1);
        }
        if (b->draw_fn) b->draw_fn(b->user, ctx, count);
        else {
            ctx->gl.BindVertexArray(b->vertex_array);
            ctx->gl.DrawElementsInstanced(GLBK_GL_TRIANGLES, (int32_t)b->index_count, GLBK_GL_UNSIGNED_INT, NULL,
                                          count);
        }
    }
    memset(&pass, 0, sizeof pass);
    pass.target = &b->cube_target;
    result = b->compute ? GLBK_OK : glbk_begin(ctx, &pass, &b->sum);
    if (result != GLBK_OK) return result;
    glbk_bind_block(ctx, GLBK_SLOT_glbk_sfield_views, &b->block);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_seen, &b->seen);
    if (b->compute) {
        glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_cube_image, &b->cube);
        return glbk_dispatch(ctx, &b->sum, b->side, tiles, 1);
    }
    ctx->gl.DrawArraysInstanced(GLBK_GL_TRIANGLE_STRIP, 0, 4, (int32_t)tiles);
    return GLBK_OK;
}

/* The cubes of a batch of eyes that take tiles of one width; faces that see nothing are not drawn. */
static glbk_result glbk__sfield_draw_cubes(glbk_context *ctx, glbk_sfield_builder *b, uint32_t count, const float *eyes)
{
    static const float none[4] = { 0, 0, 0, 0 };
    glbk_sfield_views *v = b->views;
    const uint32_t width = v->how[2], rows = b->height / width;
    uint32_t most = rows * rows < GLBK__SFIELD_TILES ? rows * rows : (uint32_t)GLBK__SFIELD_TILES;
    uint32_t tiles = 0, i, face, k;
    glbk_pass pass;
    glbk_result result;

    memset(&pass, 0, sizeof pass);
    pass.target = &b->cube_target;
    result = glbk_begin(ctx, &pass, &b->see);
    if (result != GLBK_OK) return result;
    glbk_clear(ctx, &b->cube_target, 0, none);
    v->how[1] = rows;
    for (i = 0; i < count && result == GLBK_OK; i++) {
        const float *eye = eyes + 3 * (size_t)i;
        float center[3] = { 0, 0, 0 }, radius = 1, far_depth = 0;
        for (k = 0; k < 3; k++) {
            if (!b->draw_fn) center[k] = (b->center[k] - v->sphere[k]) / v->sphere[3];
            center[k] -= eye[k];
            far_depth += center[k] * center[k];
        }
        if (!b->draw_fn) radius = b->radius / v->sphere[3];
        far_depth = 1.001f * (sqrtf(far_depth) + radius);
        for (face = 0; face < 6 && result == GLBK_OK; face++) {
            float *at = v->eyes + 4 * (size_t)tiles;
            uint32_t *place = v->places + 4 * (size_t)tiles;
            if (!glbk__sfield_faces(center, radius, face)) continue;
            memcpy(at, eye, 12);
            at[3] = 1 / far_depth;
            place[0] = face;
            place[1] = i;
            place[2] = tiles / rows;
            place[3] = tiles % rows;
            if (++tiles < most) continue;
            result = glbk__sfield_draw_tiles(ctx, b, tiles);
            tiles = 0;
        }
    }
    return result == GLBK_OK && tiles ? glbk__sfield_draw_tiles(ctx, b, tiles) : result;
}

static glbk_result glbk__sfield_read_coefs(glbk_context *ctx, glbk_sfield_builder *b, uint32_t count, float *values)
{
    const uint32_t n = b->bands * b->bands, channels = b->source ? 3 : 1, width = b->groups * channels;
    uint32_t i, c;
    glbk_pass pass;
    glbk_result result = GLBK_OK;

    memset(&pass, 0, sizeof pass);
    pass.target = &b->coef_target;
    pass.viewport[2] = (int32_t)width;
    pass.viewport[3] = (int32_t)count;
    if (!b->compute) result = glbk_begin(ctx, &pass, &b->project);
    if (result != GLBK_OK) return result;
    glbk_bind_block(ctx, GLBK_SLOT_glbk_sfield_views, &b->block);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_cube, &b->cube);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_basis, &b->basis);
    if (b->compute) {
        glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_coefs_image, &b->coefs);
        result = glbk_dispatch(ctx, &b->project, count, channels, 1);
    } else glbk_draw_screen(ctx);
    if (result == GLBK_OK) result = glbk_target_read(ctx, &b->coef_target, 0, 0, 0, width, count, b->words);
    for (i = 0; i < count && result == GLBK_OK; i++)
        for (c = 0; c < channels; c++, values += n)
            memcpy(values, b->words + 4 * ((size_t)i * width + c * b->groups), n * sizeof *values);
    return result;
}

static glbk_result glbk__sfield_read_texels(glbk_context *ctx, glbk_sfield_builder *b, uint32_t count, float *values)
{
    const uint32_t side = b->side, channels = b->source ? 3 : 1, words = b->source ? 4 : 1;
    const size_t cells = (size_t)6 * side * side;
    uint32_t i, face, x, y, c;
    const uint32_t *from = b->words;
    glbk_result result = glbk_target_read(ctx, &b->cube_target, 0, 0, 0, b->cube.width, count * side, b->words);

    for (i = 0; i < count && result == GLBK_OK; i++, values += channels * cells)
        for (y = 0; y < side; y++)
            for (face = 0; face < 6; face++)
                for (x = 0; x < side; x++, from += words)
                    for (c = 0; c < channels; c++)
                        memcpy(values + c * cells + glbk__sfield_morton(side, face, x, y), from + c, sizeof *values);
    return result;
}

GLBK_DEF glbk_result glbk_sfield_builder_see(glbk_context *ctx, glbk_sfield_builder *b, const float center[3],
                                             float radius, size_t count, const float *eyes, float *values)
{
    size_t from, i;
    glbk_result result = GLBK_OK;

    if (!ctx || !b || !b->words || !center || !(radius > 0) || !glbk__finite(radius) || !count || !eyes || !values)
        return GLBK_ERR_ARGUMENT;
    for (i = 0; i < 3 * count; i++)
        if (!(fabsf(eyes[i]) < 1e6f)) return GLBK_ERR_ARGUMENT;
    memset(b->views, 0, sizeof *b->views);
    for (i = 0; i < 3; i++) {
        if (!glbk__finite(center[i])) return GLBK_ERR_ARGUMENT;
        b->views->sphere[i] = center[i];
    }
    b->views->sphere[3] = radius;
    b->views->how[3] = b->side;
    b->views->size[0] = b->batch;
    b->views->size[1] = b->groups;
    for (from = 0; from < count && result == GLBK_OK;) {
        uint32_t width = glbk__sfield_width(b, eyes + 3 * from), n = 1;
        while (n < b->batch && from + n < count && glbk__sfield_width(b, eyes + 3 * (from + n)) == width) n++;
        b->views->how[2] = width;
        result = glbk__sfield_draw_cubes(ctx, b, n, eyes + 3 * from);
        if (result == GLBK_OK)
            result = b->bands ? glbk__sfield_read_coefs(ctx, b, n, values)
                              : glbk__sfield_read_texels(ctx, b, n, values);
        values += n * glbk__sfield_values(b) * (b->source ? 3u : 1u);
        from += n;
    }
    return result;
}

/* ---- end of sfield ---- */

/* ---- >>envsh: shadow maps ---- */

enum { GLBK__ENVSH_RECORD = 8, GLBK__ENVSH_CELL = 8, GLBK__ENVSH_MAX_SIDE = 8192 };

/* envsh_view of envshadow.h, member by member. */
typedef struct glbk__envsh_view {
    float    clip[16], lookup[12], right[3], up[3], direction[3], irradiance[3], texel[2], depth_range, spread[4];
    uint32_t x, y, page, channel;
} glbk__envsh_view;

/* As square as may be, then pages. */
static void glbk__envsh_lay_out(const glbk_context *ctx, glbk_envsh_maps *m)
{
    uint32_t side = ctx->max_size < GLBK__ENVSH_MAX_SIDE ? ctx->max_size : (uint32_t)GLBK__ENVSH_MAX_SIDE;
    uint32_t slots = (m->capacity + m->channels - 1) / m->channels, most = side / m->map_size;
    for (side = 1; side < most && side * side < slots;) side++;
    m->across = slots < side ? slots : side;
    m->down = (slots + m->across - 1) / m->across;
    m->down = m->down < most ? m->down : most;
    m->pages = m->down ? (slots + m->across * m->down - 1) / (m->across * m->down) : 0;
    for (m->cells_wide = 1, m->levels = 1; m->cells_wide * GLBK__ENVSH_CELL < m->map_size; m->levels++)
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
    texture.width = m->across * m->map_size;
    texture.height = m->down * m->map_size;
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
    if (result == GLBK_OK) result = glbk_target_create(ctx, &target, &m->atlas_target);
    texture.format = GLBK_FORMAT_RG32UI;
    texture.width = m->across * m->cells_wide;
    texture.height = m->down * m->cells_wide;
    texture.layers = m->pages * m->channels;
    texture.levels = m->levels;
    if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &m->cells);
    memset(&target, 0, sizeof target);
    target.color[0] = &m->cells;
    if (result == GLBK_OK) result = glbk_target_create(ctx, &target, &m->cell_target);
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
        source.vertex = d->vertex;
        source.fragment = d->fragment;
        source.uses = "envsh_cast";
        source.defines = defines;
        result = glbk_program_compile(ctx, &source, &m->cast);
    } else {
        result = glbk_program_create(ctx, "envsh_cast.frag", defines, &m->cast);
    }
    if (result == GLBK_OK) result = glbk_program_create(ctx, "envsh_cells.frag", defines, &m->make_cells);
    return result;
}

GLBK_DEF glbk_result glbk_envsh_maps_create(glbk_context *ctx, const glbk_envsh_maps_desc *d, glbk_envsh_maps *out)
{
    glbk_result result;
    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!d || !d->capacity || d->capacity > GLBK_ENVSH_MAX_LIGHTS || (d->vertex != NULL) != (d->fragment != NULL))
        return GLBK_ERR_ARGUMENT;
    out->capacity = d->capacity;
    out->map_size = d->map_size ? d->map_size : 256;
    out->guard = d->guard ? d->guard : 4;
    out->channels = d->rgba ? 4 : 1;
    if (out->map_size < 16 || out->map_size > 4096 || out->guard > out->map_size / 4) result = GLBK_ERR_ARGUMENT;
    else {
        glbk__envsh_lay_out(ctx, out);
        result = out->pages && out->pages <= 1024 ? glbk__envsh_create_textures(ctx, out) : GLBK_ERR_LIMIT;
    }
    if (result == GLBK_OK) result = glbk__envsh_create_programs(ctx, d, out);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_scene), NULL, &out->scene);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_query), NULL, &out->query);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_object), NULL, &out->object);
    if (result == GLBK_OK) return GLBK_OK;
    glbk_envsh_maps_destroy(ctx, out);
    return result;
}

GLBK_DEF void glbk_envsh_maps_destroy(glbk_context *ctx, glbk_envsh_maps *m)
{
    if (!m) return;
    glbk_program_destroy(ctx, &m->cast);
    glbk_program_destroy(ctx, &m->make_cells);
    glbk_target_destroy(ctx, &m->atlas_target);
    glbk_target_destroy(ctx, &m->cell_target);
    glbk_texture_destroy(ctx, &m->atlas);
    glbk_texture_destroy(ctx, &m->depth);
    glbk_texture_destroy(ctx, &m->cells);
    glbk_texture_destroy(ctx, &m->views);
    glbk_buffer_destroy(ctx, &m->scene);
    glbk_buffer_destroy(ctx, &m->query);
    glbk_buffer_destroy(ctx, &m->object);
    memset(m, 0, sizeof *m);
}

/* A light's eight texels. */
static void glbk__envsh_record(const glbk_envsh_maps *m, const glbk__envsh_view *v, uint32_t light, uint32_t *words)
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

static glbk_result glbk__envsh_upload(glbk_context *ctx, glbk_envsh_maps *m, const char *views, uint32_t count)
{
    glbk__allocator memory = glbk__memory(ctx);
    uint32_t *words = (uint32_t *)glbk__alloc_array(&memory, (size_t)count + 1, 4 * 4 * GLBK__ENVSH_RECORD), i;
    glbk_envsh_scene scene;
    glbk_result result = GLBK_OK;

    if (!words) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i++) {
        glbk__envsh_view v;
        memcpy(&v, views + i * sizeof v, sizeof v);
        glbk__envsh_record(m, &v, i, words + 4 * GLBK__ENVSH_RECORD * (size_t)i);
    }
    if (count) result = glbk_table_update(ctx, &m->views, 0, GLBK__ENVSH_RECORD * (size_t)count, words);
    glbk__free(&memory, words);
    if (result != GLBK_OK) return result;
    memset(&scene, 0, sizeof scene);
    scene.tiles[0] = m->map_size;
    scene.tiles[1] = m->guard;
    scene.tiles[2] = m->channels;
    scene.tiles[3] = m->cells_wide;
    scene.range[0] = m->count = count;
    scene.range[1] = m->levels;
    scene.page[0] = 2.0f / (float)(m->across * m->map_size);
    scene.page[1] = 2.0f / (float)(m->down * m->map_size);
    scene.page[2] = 2.0f / (float)(m->map_size - 2 * m->guard);
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
                                          uint32_t column, glbk_envsh_draw draw, void *user)
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
        ctx->gl.Viewport((int32_t)(column * m->map_size + m->guard), 0, (int32_t)(m->map_size - 2 * m->guard),
                         (int32_t)m->atlas_target.height);
    glbk__envsh_clip(ctx, 1);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_views, &m->views);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_envsh_scene, &m->scene);
    m->first = first;
    m->step = step;
    result = draw(user, ctx, m, (end - first + step - 1) / step);
    if (!ctx->lost) glbk__envsh_clip(ctx, 0);
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

GLBK_DEF glbk_result glbk_envsh_maps_render(glbk_context *ctx, glbk_envsh_maps *m, const void *views, size_t view_size,
                                            uint32_t count, glbk_envsh_draw draw, void *user)
{
    uint32_t pages, page, channel, column, layer;
    glbk_result result;

    if (!ctx || !m || !m->views.name || count > m->capacity || (count && !views) || !draw ||
        view_size != sizeof(glbk__envsh_view))
        return GLBK_ERR_ARGUMENT;
    m->count = 0;
    result = glbk__envsh_upload(ctx, m, (const char *)views, count);
    pages = (count + m->across * m->down * m->channels - 1) / (m->across * m->down * m->channels);
    for (page = 0; page < pages; page++)
        for (channel = 0; channel < m->channels; channel++)
            for (column = 0; column < (ctx->es ? m->across : 1) && result == GLBK_OK; column++)
                result = glbk__envsh_cast_round(ctx, m, page, channel, column, draw, user);
    for (layer = 0; layer < pages * m->channels && result == GLBK_OK; layer++)
        result = glbk__envsh_cell_layer(ctx, m, layer);
    if (result != GLBK_OK) m->count = 0;
    return result;
}

/* ---- >>envsh: questions ---- */

/* The ranges of envsh_query. */
static int glbk__envsh_question_valid(const glbk_envsh_question *q)
{
    static const float most[] = { 0, 8, 32, 64 };
    if (!q || (unsigned)q->filter >= GLBK_ENVSH_FILTER_COUNT || !(q->bias >= 0 && q->bias <= 1e6f)) return 0;
    if (q->filter == GLBK_ENVSH_FILTER_PLAIN) return 1;
    if (!(q->radius >= (q->filter == GLBK_ENVSH_FILTER_SMOOTH ? 0.5f : 0.0f) && q->radius <= most[q->filter])) return 0;
    if (q->filter == GLBK_ENVSH_FILTER_SMOOTH) return 1;
    return q->taps >= 1 && q->taps <= GLBK_ENVSH_MAX_TAPS && q->extent_scale >= 0 && q->extent_scale <= 1e6f;
}

/* Vogel's spiral, turned by the golden angle from tap to tap. */
static void glbk__envsh_fill_query(const glbk_envsh_question *q, glbk_envsh_query *out)
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
    for (i = 0; i < q->taps && i < GLBK_ENVSH_MAX_TAPS; i++) {
        float radius = sqrtf(((float)i + 0.5f) / (float)q->taps);
        out->disc[2 * i] = radius * (float)x;
        out->disc[2 * i + 1] = radius * (float)y;
        t = x * cosine - y * sine;
        y = x * sine + y * cosine;
        x = t;
    }
}

static void glbk__envsh_bind_all(glbk_context *ctx, const glbk_envsh_maps *m)
{
    glbk_bind_texture(ctx, m->channels == 4 ? GLBK_SLOT_glbk_envsh_depth4 : GLBK_SLOT_glbk_envsh_depth, &m->atlas);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_cells, &m->cells);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_views, &m->views);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_envsh_scene, &m->scene);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_envsh_query, &m->query);
}

GLBK_DEF glbk_result glbk_envsh_bind(glbk_context *ctx, glbk_envsh_maps *m, const glbk_envsh_question *question)
{
    glbk_envsh_query query;
    glbk_result result;
    if (!ctx || !m || !m->query.name || !glbk__envsh_question_valid(question)) return GLBK_ERR_ARGUMENT;
    glbk__envsh_fill_query(question, &query);
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_query, &m->query, &query);
    if (result == GLBK_OK) glbk__envsh_bind_all(ctx, m);
    return result;
}

/* ---- >>envsh: the renderer ---- */

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
    texture.format = GLBK_FORMAT_RGBA32UI;
    for (i = 0; i < 4 && result == GLBK_OK; i++) {
        result = glbk_texture_create(ctx, &texture, &out->gbuffer[i]);
        target.color[i] = &out->gbuffer[i];
    }
    texture.format = GLBK_FORMAT_DEPTH32F;
    if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &out->depth);
    target.depth = &out->depth;
    if (result == GLBK_OK) result = glbk_target_create(ctx, &target, &out->gbuffer_target);
    texture.format = GLBK_FORMAT_COLOR;
    out->compute = ctx->compute;
    for (i = 0; i < (out->compute ? 1 : 2) && result == GLBK_OK; i++) {
        memset(&target, 0, sizeof target);
        result = glbk_texture_create(ctx, &texture, &out->sums[i]);
        target.color[0] = &out->sums[i];
        if (result == GLBK_OK) result = glbk_target_create(ctx, &target, &out->targets[i]);
    }
    if (result == GLBK_OK) result = glbk_program_create(ctx, "envsh_gbuffer.frag", NULL, &out->fill);
    if (result == GLBK_OK) result = glbk_program_create(ctx, "envsh_resolve.frag", NULL, &out->resolve);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_object), NULL, &out->object);
    if (result != GLBK_OK) glbk_envsh_renderer_destroy(ctx, out);
    return result;
}

GLBK_DEF void glbk_envsh_renderer_destroy(glbk_context *ctx, glbk_envsh_renderer *r)
{
    uint32_t i;
    if (!r) return;
    for (i = 0; i < 2 * GLBK_ENVSH_FILTER_COUNT; i++) glbk_program_destroy(ctx, &r->shade[i]);
    glbk_program_destroy(ctx, &r->fill);
    glbk_program_destroy(ctx, &r->resolve);
    glbk_target_destroy(ctx, &r->gbuffer_target);
    for (i = 0; i < 4; i++) glbk_texture_destroy(ctx, &r->gbuffer[i]);
    glbk_texture_destroy(ctx, &r->depth);
    for (i = 0; i < 2; i++) {
        glbk_target_destroy(ctx, &r->targets[i]);
        glbk_texture_destroy(ctx, &r->sums[i]);
    }
    glbk_buffer_destroy(ctx, &r->object);
    memset(r, 0, sizeof *r);
}

GLBK_DEF glbk_result glbk_envsh_gbuffer_upload(glbk_context *ctx, glbk_envsh_renderer *r, uint32_t row, uint32_t rows,
                                               const glbk_envsh_pixel *pixels)
{
    glbk__allocator memory;
    size_t count, i;
    float *texels, seen;
    glbk_result result = GLBK_OK;
    int k;

    if (!ctx || !r || !r->gbuffer[0].name || !rows || row >= r->height || rows > r->height - row || !pixels)
        return GLBK_ERR_ARGUMENT;
    memory = glbk__memory(ctx);
    count = (size_t)r->width * rows;
    texels = (float *)glbk__alloc_array(&memory, count, 16);
    if (!texels) return GLBK_ERR_ALLOC;
    for (k = 0; k < 4 && result == GLBK_OK; k++) {
        for (i = 0; i < count; i++) {
            const glbk_envsh_pixel *p = &pixels[i];
            const float *v = k == 0 ? p->position : k == 1 ? p->normal : k == 2 ? p->geometric : p->albedo;
            seen = k == 0 && p->seen ? 1.0f : 0.0f;
            memcpy(texels + 4 * i, v, 12);
            texels[4 * i + 3] = seen;
        }
        result = glbk_texture_update(ctx, &r->gbuffer[k], 0, 0, row, 0, r->width, rows, 1, texels);
    }
    glbk__free(&memory, texels);
    return result;
}

GLBK_DEF glbk_result glbk_envsh_gbuffer_begin(glbk_context *ctx, glbk_envsh_renderer *r)
{
    static const float zero[4] = { 0, 0, 0, 0 };
    glbk_pass pass;
    glbk_result result;
    uint32_t i;

    if (!ctx || !r || !r->gbuffer_target.name) return GLBK_ERR_ARGUMENT;
    memset(&pass, 0, sizeof pass);
    pass.target = &r->gbuffer_target;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_begin(ctx, &pass, &r->fill);
    if (result != GLBK_OK) return result;
    for (i = 0; i < 4; i++) glbk_clear(ctx, &r->gbuffer_target, i, zero);
    glbk_clear_depth(ctx, 1);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_color_map, NULL);       /* until an object has one */
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_envsh_gbuffer_object(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_envsh_surface *s)
{
    glbk_envsh_object object;
    glbk_result result;

    if (!ctx || !r || !r->object.name || !s) return GLBK_ERR_ARGUMENT;
    memset(&object, 0, sizeof object);
    memcpy(object.world, s->world, sizeof object.world);
    memcpy(object.clip, s->clip, sizeof object.clip);
    memcpy(object.eye, s->eye, sizeof s->eye);
    memcpy(object.color, s->albedo, sizeof object.color);
    object.eye[3] = s->alpha_cutoff;
    object.lights[2] = s->color_map ? 1 : 0;
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_object, &r->object, &object);
    if (result != GLBK_OK) return result;
    if (s->color_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_color_map, s->color_map);
    return GLBK_OK;
}

static glbk_result glbk__envsh_shade_program(glbk_context *ctx, glbk_envsh_renderer *r, uint32_t filter, uint32_t rgba,
                                             glbk_program **out)
{
    char defines[] = "ENVSH_FILTER=0 ENVSH_RGBA=0";
    *out = &r->shade[2 * filter + rgba];
    if ((*out)->name) return GLBK_OK;
    defines[13] = (char)('0' + filter);
    defines[26] = (char)('0' + rgba);
    return glbk_program_create(ctx, r->compute ? "envsh_shade.comp" : "envsh_shade.frag", defines, *out);
}

/* The lights of m->query's range. */
static glbk_result glbk__envsh_shade_pass(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_envsh_maps *m,
                                          glbk_program *program)
{
    glbk_result result;
    glbk_pass pass;
    uint32_t i;

    memset(&pass, 0, sizeof pass);
    pass.target = &r->targets[!r->now];
    result = r->compute ? GLBK_OK : glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    glbk__envsh_bind_all(ctx, m);
    for (i = 0; i < 3; i++) glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_place + i, &r->gbuffer[i]);
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

GLBK_DEF glbk_result glbk_envsh_shade(glbk_context *ctx, glbk_envsh_renderer *r, glbk_envsh_maps *m,
                                      const glbk_envsh_question *q, uint32_t lights_per_pass, int add)
{
    glbk_envsh_query query;
    glbk_program *program;
    glbk_result result;
    uint32_t from = 0;

    if (!ctx || !r || !r->targets[0].name || !m || !m->query.name || !glbk__envsh_question_valid(q))
        return GLBK_ERR_ARGUMENT;
    result = glbk__envsh_shade_program(ctx, r, (uint32_t)q->filter, m->channels == 4, &program);
    if (result != GLBK_OK) return result;
    if (!add) r->begun = 0;
    if (!lights_per_pass) lights_per_pass = GLBK_ENVSH_MAX_LIGHTS;
    glbk__envsh_fill_query(q, &query);
    for (; from < m->count && result == GLBK_OK; from = query.range[1]) {
        query.range[0] = from;
        query.range[1] = m->count - from < lights_per_pass ? m->count : from + lights_per_pass;
        query.range[2] = r->width;
        query.range[3] = r->begun != 0;
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_query, &m->query, &query);
        if (result == GLBK_OK) result = glbk__envsh_shade_pass(ctx, r, m, program);
    }
    return result;
}

GLBK_DEF glbk_result glbk_envsh_illuminate(glbk_context *ctx, glbk_envsh_renderer *r, glbk_envsh_maps *m,
                                           const void *views, size_t view_size, uint32_t count, glbk_envsh_draw draw,
                                           void *user, const glbk_envsh_question *q)
{
    const char *at = (const char *)views;
    uint32_t first = 0, n;
    glbk_result result;
    if (!ctx || !m || !m->capacity || (!views && count)) return GLBK_ERR_ARGUMENT;
    do {
        n = count - first < m->capacity ? count - first : m->capacity;
        result = glbk_envsh_maps_render(ctx, m, n ? at + first * view_size : NULL, view_size, n, draw, user);
        if (result == GLBK_OK) result = glbk_envsh_shade(ctx, r, m, q, 0, first != 0);
        first += n;
    } while (first < count && result == GLBK_OK);
    return result;
}

GLBK_DEF glbk_result glbk_envsh_resolve(glbk_context *ctx, glbk_envsh_renderer *r, const glbk_pass *pass)
{
    glbk_envsh_object object;
    glbk_result result;

    if (!ctx || !r || !r->resolve.name || !pass) return GLBK_ERR_ARGUMENT;
    memset(&object, 0, sizeof object);
    object.lights[3] = r->begun != 0;
    result = glbk__corner(ctx, pass, r->width, r->height, object.lights);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_object, &r->object, &object);
    if (result == GLBK_OK) result = glbk_begin(ctx, pass, &r->resolve);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_color, &r->gbuffer[3]);
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

/* ---- end of envsh ---- */

/* ---- >>rsm: maps ---- */

enum {
    GLBK__RSM_FILL_LIGHT,
    GLBK__RSM_FILL_VIEW,
    GLBK__RSM_SCAN,
    GLBK__RSM_SCAN_ON,
    GLBK__RSM_SCAN_ROWS,
    GLBK__RSM_SCAN_ROWS_ON,
    GLBK__RSM_PICK,
    GLBK__RSM_PICK_ALL,
    GLBK__RSM_DIRECT,
    GLBK__RSM_GATHER,
    GLBK__RSM_INTERPOLATE,
    GLBK__RSM_RECALL,
    GLBK__RSM_SMOOTH,
    GLBK__RSM_RESOLVE,
    GLBK__RSM_DO_SCAN,          /* by compute, from here on */
    GLBK__RSM_DO_SCAN_ROWS,
    GLBK__RSM_DO_GATHER,
    GLBK__RSM_DO_NODES,
    GLBK__RSM_GATHER_SURFACES,  /* of the three, with near_field */
    GLBK__RSM_DO_GATHER_SURFACES,
    GLBK__RSM_DO_NODES_SURFACES,
    GLBK__RSM_DO_BEGIN,
    GLBK__RSM_DO_INTERPOLATE,
    GLBK__RSM_DO_LISTED,
    GLBK__RSM_DO_SMOOTH,
    GLBK__RSM_LIST = 1024 * 64, /* pixel lights that the list has room for */
    GLBK__RSM_NONE = 9          /* no picture */
};

static const char *const glbk__rsm_programs[GLBK_RSM_PROGRAMS][2] = {
    { "rsm_fill.frag", "FOR_LIGHT=1" }, { "rsm_fill.frag", "FOR_LIGHT=0" }, { "rsm_scan.frag", "FROM=0" },
    { "rsm_scan.frag", "FROM=1" },      { "rsm_scan.frag", "FROM=2" },      { "rsm_scan.frag", "FROM=3" },
    { "rsm_pick.frag", "ALL=0" },       { "rsm_pick.frag", "ALL=1" },       { "rsm_direct.frag", NULL },
    { "rsm_gather.frag", NULL },        { "rsm_interpolate.frag", NULL },   { "rsm_recall.frag", NULL },
    { "rsm_smooth.frag", NULL },        { "rsm_resolve.frag", NULL },
    { "rsm_scan.comp", "ROWS=0" },      { "rsm_scan.comp", "ROWS=1" },      { "rsm_gather.comp", "NODES=0" },
    { "rsm_gather.comp", "NODES=1" },   { "rsm_gather.frag", "RSM_SURFACES=1" },
    { "rsm_gather.comp", "NODES=0 RSM_SURFACES=1" },
    { "rsm_gather.comp", "NODES=1 RSM_SURFACES=1" },                        { "rsm_begin.comp", NULL },
    { "rsm_interpolate.comp", "RSM_GROUP=256" },
    { "rsm_interpolate.comp", "RSM_GROUP=64" },                             { "rsm_smooth.comp", NULL }
};

static int glbk__rsm_small(const float *v, float most)        /* three floats; false for what is not a number */
{
    return fabsf(v[0]) <= most && fabsf(v[1]) <= most && fabsf(v[2]) <= most;
}

/* What rsm.h's check of a light refuses, and its defaults. */
static int glbk__rsm_lamp_valid(glbk_rsm_lamp *l)
{
    float d2 =
        l->direction[0] * l->direction[0] + l->direction[1] * l->direction[1] + l->direction[2] * l->direction[2];
    int i;
    if (l->kind == GLBK_RSM_DEFAULT) l->kind = GLBK_RSM_SUN;
    if ((unsigned)l->kind >= GLBK_RSM_KIND_COUNT || !glbk__rsm_small(l->position, 1e9f) ||
        !glbk__rsm_small(l->up, 1e9f))
        return 0;
    if (l->kind != GLBK_RSM_POINT && !(fabsf(d2 - 1.0f) <= 2e-3f)) return 0;
    for (i = 0; i < 3; i++)
        if (!(l->value[i] >= 0.0f && l->value[i] <= 1e12f)) return 0;
    if (l->kind == GLBK_RSM_SUN && !(l->radius > 0.0f && l->radius <= 1e9f)) return 0;
    if (l->kind == GLBK_RSM_SPOT && !(l->cone_angle > 1e-3f && l->cone_angle <= 6.28f)) return 0;
    if (l->kind == GLBK_RSM_SQUARE_SPOT && !(l->cone_angle > 1e-3f && l->cone_angle <= 2.0f)) return 0;
    if (!(fabsf(l->near_depth) > 0.0f) && !(fabsf(l->far_depth) > 0.0f)) {
        l->near_depth = l->kind == GLBK_RSM_SUN ? -l->radius : 1e-3f;
        l->far_depth = l->kind == GLBK_RSM_SUN ? l->radius : 1e3f;
    }
    if (!(l->near_depth < l->far_depth && fabsf(l->near_depth) <= 1e9f && l->far_depth <= 1e9f)) return 0;
    return l->kind == GLBK_RSM_SUN || l->near_depth > 0.0f;
}

static uint32_t glbk__rsm_face_count(const glbk_rsm_lamp *l)
{
    if (l->kind == GLBK_RSM_PATCH) return 5;
    return l->kind == GLBK_RSM_POINT || (l->kind == GLBK_RSM_SPOT && l->cone_angle > 2.0f) ? 6 : 1;
}

static void glbk__rsm_set4(float *out, glbk__v3 v, float w)
{
    glbk__v3_store(out, v);
    out[3] = w;
}

/* The block that shaders know the light by; twin of rsm__map_set. */
static void glbk__rsm_frame_of(glbk_rsm_map *map)
{
    const glbk_rsm_lamp *l = &map->lamp;
    glbk__v3 axis = glbk__v3_make(0, 0, -1), up = glbk__v3_make(0, 1, 0), right;
    float extent = 1.0f, cos_half = -1.0f;
    if (l->kind != GLBK_RSM_POINT) {
        axis = glbk__v3_normalize(glbk__v3_load(l->direction));
        if (l->kind == GLBK_RSM_SUN) axis = glbk__v3_scale(axis, -1);
        up = glbk__v3_normalize(glbk__v3_load(l->up));
    }
    if (glbk__v3_length(glbk__v3_cross(axis, up)) < 1e-3f)
        up = fabsf(axis.y) < 0.9f ? glbk__v3_make(0, 1, 0) : glbk__v3_make(0, 0, 1);
    right = glbk__v3_normalize(glbk__v3_cross(axis, up));
    up = glbk__v3_cross(right, axis);
    if (l->kind == GLBK_RSM_SUN) extent = l->radius;
    if ((l->kind == GLBK_RSM_SPOT && map->faces == 1) || l->kind == GLBK_RSM_SQUARE_SPOT)
        extent = tanf(0.5f * l->cone_angle);
    if (l->kind == GLBK_RSM_SPOT) cos_half = cosf(0.5f * l->cone_angle);
    glbk__rsm_set4(map->block.position, glbk__v3_load(l->position), extent);
    glbk__rsm_set4(map->block.right, right, (float)l->kind);
    glbk__rsm_set4(map->block.up, up, (float)map->faces);
    glbk__rsm_set4(map->block.axis, axis, cos_half);
    glbk__rsm_set4(map->block.value, glbk__v3_load(l->value), (float)map->size);
}

/* Directions of a face; twin of rsm__face_frame. */
static void glbk__rsm_face_frame(const glbk_rsm_map *map, uint32_t face, glbk__v3 *r, glbk__v3 *u, glbk__v3 *a)
{
    glbk__v3 right = glbk__v3_load(map->block.right), up = glbk__v3_load(map->block.up);
    glbk__v3 axis = glbk__v3_load(map->block.axis);
    *r = right;
    *u = up;
    *a = axis;
    switch (face) {
    case 1: *r = glbk__v3_scale(axis, -1); *a = right; break;
    case 2: *r = axis; *a = glbk__v3_scale(right, -1); break;
    case 3: *u = glbk__v3_scale(axis, -1); *a = up; break;
    case 4: *u = axis; *a = glbk__v3_scale(up, -1); break;
    case 5: *r = glbk__v3_scale(right, -1); *a = glbk__v3_scale(axis, -1); break;
    default: break;
    }
}

GLBK_DEF void glbk_rsm_map_matrix(const glbk_rsm_map *map, uint32_t face, float m[16])
{
    glbk__v3 r, u, a, p;
    float n, f, s, z0, z1;
    int i, perspective;
    if (!map || !m || face >= map->faces) return;
    perspective = map->lamp.kind != GLBK_RSM_SUN;
    glbk__rsm_face_frame(map, face, &r, &u, &a);
    p = glbk__v3_load(map->lamp.position);
    n = map->lamp.near_depth;
    f = map->lamp.far_depth;
    s = 1.0f / map->block.position[3];
    z0 = perspective ? (f + n) / (f - n) : 2.0f / (f - n);
    z1 = perspective ? -2.0f * n * f / (f - n) : -2.0f * n / (f - n) - 1.0f;
    for (i = 0; i < 3; i++) {
        float axis = i == 0 ? a.x : i == 1 ? a.y : a.z;
        m[4 * i] = s * (i == 0 ? r.x : i == 1 ? r.y : r.z);
        m[4 * i + 1] = s * (i == 0 ? u.x : i == 1 ? u.y : u.z);
        m[4 * i + 2] = z0 * axis;
        m[4 * i + 3] = perspective ? axis : 0.0f;
    }
    m[12] = -s * glbk__v3_dot(r, p);
    m[13] = -s * glbk__v3_dot(u, p);
    m[14] = z1 - z0 * glbk__v3_dot(a, p);
    m[15] = perspective ? -glbk__v3_dot(a, p) : 1.0f;
}

static glbk_result glbk__rsm_image(glbk_context *ctx, glbk_format format, uint32_t width, uint32_t height,
                                   uint32_t layers, glbk_texture *out)
{
    glbk_texture_desc d;
    memset(&d, 0, sizeof d);
    d.format = format;
    d.width = width;
    d.height = height;
    d.layers = layers;
    return glbk_texture_create(ctx, &d, out);
}

/* Layers first .. first + count - 1 as targets of one framebuffer. */
static glbk_result glbk__rsm_target(glbk_context *ctx, const glbk_texture *texture, uint32_t first, uint32_t count,
                                    const glbk_texture *depth, glbk_target *out)
{
    glbk_target_desc d;
    uint32_t i;
    memset(&d, 0, sizeof d);
    for (i = 0; i < count; i++) {
        d.color[i] = texture;
        d.layer[i] = first + i;
    }
    d.depth = depth;
    return glbk_target_create(ctx, &d, out);
}

static glbk_result glbk__rsm_map_images(glbk_context *ctx, glbk_rsm_map *map)
{
    uint32_t n = map->size, f, i;
    glbk_result result = glbk__rsm_image(ctx, GLBK_FORMAT_RGBA32UI, n, n, 3 * map->faces, &map->texels);
    if (result == GLBK_OK) result = glbk__rsm_image(ctx, GLBK_FORMAT_DEPTH32F, n, n, 0, &map->depth);
    for (i = 0; i < 2; i++) {
        if (result == GLBK_OK) result = glbk__rsm_image(ctx, GLBK_FORMAT_R32UI, n, n, map->faces, &map->sums[i]);
        if (result == GLBK_OK) result = glbk__rsm_image(ctx, GLBK_FORMAT_R32UI, n, 1, map->faces, &map->rows[i]);
        for (f = 0; f < map->faces && result == GLBK_OK; f++) {
            result = glbk__rsm_target(ctx, &map->sums[i], f, 1, NULL, &map->sum_targets[i][f]);
            if (result == GLBK_OK) result = glbk__rsm_target(ctx, &map->rows[i], f, 1, NULL, &map->row_targets[i][f]);
        }
    }
    for (f = 0; f < map->faces && result == GLBK_OK; f++)
        result = glbk__rsm_target(ctx, &map->texels, 3 * f, 3, &map->depth, &map->faces_drawn[f]);
    return result;
}

GLBK_DEF glbk_result glbk_rsm_map_create(glbk_context *ctx, const glbk_rsm_lamp *lamp, uint32_t size, glbk_rsm_map *out)
{
    glbk_result result;

    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!lamp) return GLBK_ERR_ARGUMENT;
    out->lamp = *lamp;
    if (!glbk__rsm_lamp_valid(&out->lamp) || (size && (size < 4 || size > 4096))) {
        memset(out, 0, sizeof *out);
        return GLBK_ERR_ARGUMENT;
    }
    out->faces = glbk__rsm_face_count(&out->lamp);
    out->size = size ? size : out->faces > 1 ? 256 : 512;
    glbk__rsm_frame_of(out);
    result = glbk__rsm_map_images(ctx, out);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof out->block, &out->block, &out->light);
    if (result != GLBK_OK) glbk_rsm_map_destroy(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_rsm_map_place(glbk_context *ctx, glbk_rsm_map *map, const glbk_rsm_lamp *lamp)
{
    glbk_rsm_lamp l;
    if (!ctx || !map || !map->light.name || !lamp) return GLBK_ERR_ARGUMENT;
    l = *lamp;
    if (!glbk__rsm_lamp_valid(&l) || glbk__rsm_face_count(&l) != map->faces) return GLBK_ERR_ARGUMENT;
    map->lamp = l;
    map->summed = 0;
    glbk__rsm_frame_of(map);
    return glbk_buffer_update(ctx, &map->light, 0, sizeof map->block, &map->block);
}

/* Between rsm_texel, three times 16 bytes, and the three layers of a face: rows of one layer. */
static void glbk__rsm_shuffle(unsigned char *texels, unsigned char *layer, size_t count, size_t k, int out)
{
    size_t i;
    for (i = 0; i < count; i++)
        if (out) memcpy(texels + 48 * i + 16 * k, layer + 16 * i, 16);
        else memcpy(layer + 16 * i, texels + 48 * i + 16 * k, 16);
}

GLBK_DEF glbk_result glbk_rsm_map_upload(glbk_context *ctx, glbk_rsm_map *map, const void *texels)
{
    glbk__allocator memory;
    unsigned char *layer;
    size_t count;
    uint32_t i;
    glbk_result result = GLBK_OK;

    if (!ctx || !map || !map->texels.name || !texels) return GLBK_ERR_ARGUMENT;
    memory = glbk__memory(ctx);
    count = (size_t)map->size * map->size;
    layer = (unsigned char *)glbk__alloc_array(&memory, count, 64);
    if (!layer) return GLBK_ERR_ALLOC;
    for (i = 0; i < 3 * map->faces && result == GLBK_OK; i++) {
        if (i % 3 == 0) memcpy(layer + 16 * count, (const unsigned char *)texels + 48 * count * (i / 3), 48 * count);
        glbk__rsm_shuffle(layer + 16 * count, layer, count, i % 3, 0);
        result = glbk_texture_update(ctx, &map->texels, 0, 0, 0, i, map->size, map->size, 1, layer);
    }
    glbk__free(&memory, layer);
    map->summed = 0;
    return result;
}

GLBK_DEF glbk_result glbk_rsm_map_read(glbk_context *ctx, const glbk_rsm_map *map, uint32_t face, void *texels)
{
    glbk__allocator memory;
    unsigned char *layer;
    size_t count;
    uint32_t k;
    glbk_result result = GLBK_OK;

    if (!ctx || !map || !map->texels.name || face >= map->faces || !texels) return GLBK_ERR_ARGUMENT;
    memory = glbk__memory(ctx);
    count = (size_t)map->size * map->size;
    layer = (unsigned char *)glbk__alloc_array(&memory, count, 16);
    if (!layer) return GLBK_ERR_ALLOC;
    for (k = 0; k < 3 && result == GLBK_OK; k++) {
        result = glbk_target_read(ctx, &map->faces_drawn[face], k, 0, 0, map->size, map->size, layer);
        if (result == GLBK_OK) glbk__rsm_shuffle((unsigned char *)texels, layer, count, k, 1);
    }
    glbk__free(&memory, layer);
    return result;
}

GLBK_DEF void glbk_rsm_map_destroy(glbk_context *ctx, glbk_rsm_map *map)
{
    uint32_t i, f;
    if (!map) return;
    for (f = 0; f < 6; f++) {
        glbk_target_destroy(ctx, &map->faces_drawn[f]);
        for (i = 0; i < 2; i++) {
            glbk_target_destroy(ctx, &map->sum_targets[i][f]);
            glbk_target_destroy(ctx, &map->row_targets[i][f]);
        }
    }
    for (i = 0; i < 2; i++) {
        glbk_texture_destroy(ctx, &map->sums[i]);
        glbk_texture_destroy(ctx, &map->rows[i]);
    }
    glbk_texture_destroy(ctx, &map->texels);
    glbk_texture_destroy(ctx, &map->depth);
    glbk_buffer_destroy(ctx, &map->light);
    memset(map, 0, sizeof *map);
}

/* ---- >>rsm: the renderer ---- */

static glbk_result glbk__rsm_pictures(glbk_context *ctx, uint32_t count, uint32_t width, uint32_t height,
                                      glbk_texture *textures, glbk_target *targets)
{
    glbk_result result = GLBK_OK;
    uint32_t i;
    for (i = 0; i < count && result == GLBK_OK; i++) {
        result = glbk__rsm_image(ctx, GLBK_FORMAT_COLOR, width, height, 0, &textures[i]);
        if (result == GLBK_OK) result = glbk__rsm_target(ctx, &textures[i], 0, 1, NULL, &targets[i]);
    }
    return result;
}

enum { GLBK__RSM_LISTS = 13 };     /* nodes and open pixels of six grids, nodes of none after them */

static glbk_result glbk__rsm_lists(glbk_context *ctx, glbk_rsm_renderer *r)
{
    size_t pixels = (size_t)r->width * r->height, nodes = (size_t)(r->width / 2 + 2) * (r->height / 2 + 2);
    glbk_result result = glbk_buffer_create(ctx, 16 * GLBK__RSM_LISTS, NULL, &r->counts);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, 4 * pixels, NULL, &r->open[0]);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, 4 * pixels, NULL, &r->open[1]);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, 4 * nodes, NULL, &r->wanted);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, nodes / 8 + 4, NULL, &r->marks);
    return result;
}

static glbk_result glbk__rsm_renderer_images(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_rsm_renderer_desc *d)
{
    uint32_t w = d->width, h = d->height, i;
    glbk_result result = glbk__rsm_image(ctx, GLBK_FORMAT_DEPTH32F, w, h, 0, &r->depth);
    for (i = 0; i < (d->denoise ? 2u : 1u) && result == GLBK_OK; i++) {
        result = glbk__rsm_image(ctx, GLBK_FORMAT_RGBA32UI, w, h, 3, &r->seen[i]);
        if (result == GLBK_OK) result = glbk__rsm_target(ctx, &r->seen[i], 0, 3, &r->depth, &r->seen_targets[i]);
    }
    if (result == GLBK_OK)
        result = glbk__rsm_image(ctx, GLBK_FORMAT_RGBA32UI, 1024, GLBK__RSM_LIST / 1024, 4, &r->lights);
    if (result == GLBK_OK) result = glbk__rsm_target(ctx, &r->lights, 0, 4, NULL, &r->lights_target);
    if (result == GLBK_OK) result = glbk__rsm_pictures(ctx, 3, w, h, r->sums, r->targets);
    if (result == GLBK_OK && d->interpolate)
        result = glbk__rsm_pictures(ctx, r->compute ? 1 : 3, w / 2 + 2, h / 2 + 2, r->grids, r->grid_targets);
    if (result == GLBK_OK && d->interpolate && r->compute) result = glbk__rsm_lists(ctx, r);
    if (result == GLBK_OK && d->denoise) result = glbk__rsm_pictures(ctx, 2, w, h, r->history, r->history_targets);
    return result;
}

GLBK_DEF glbk_result glbk_rsm_renderer_create(glbk_context *ctx, const glbk_rsm_renderer_desc *d,
                                              glbk_rsm_renderer *out)
{
    glbk_result result;

    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!d || !d->width || !d->height) return GLBK_ERR_ARGUMENT;
    out->width = d->width;
    out->height = d->height;
    out->direct = out->bounce = GLBK__RSM_NONE;
    out->compute = ctx->compute && (!d->interpolate || 4 * (size_t)d->width * d->height <= ctx->max_storage);
    result = glbk__rsm_renderer_images(ctx, out, d);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof out->values, NULL, &out->frame);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof out->drawn, NULL, &out->object);
    if (result != GLBK_OK) glbk_rsm_renderer_destroy(ctx, out);
    return result;
}

GLBK_DEF void glbk_rsm_renderer_destroy(glbk_context *ctx, glbk_rsm_renderer *r)
{
    uint32_t i;
    if (!r) return;
    for (i = 0; i < GLBK_RSM_PROGRAMS; i++) glbk_program_destroy(ctx, &r->programs[i]);
    for (i = 0; i < 3; i++) {
        glbk_target_destroy(ctx, &r->targets[i]);
        glbk_target_destroy(ctx, &r->grid_targets[i]);
        glbk_texture_destroy(ctx, &r->sums[i]);
        glbk_texture_destroy(ctx, &r->grids[i]);
    }
    for (i = 0; i < 2; i++) {
        glbk_target_destroy(ctx, &r->seen_targets[i]);
        glbk_target_destroy(ctx, &r->history_targets[i]);
        glbk_texture_destroy(ctx, &r->seen[i]);
        glbk_texture_destroy(ctx, &r->history[i]);
    }
    glbk_target_destroy(ctx, &r->lights_target);
    glbk_texture_destroy(ctx, &r->lights);
    glbk_texture_destroy(ctx, &r->depth);
    glbk_texture_destroy(ctx, &r->pattern);
    glbk_texture_destroy(ctx, &r->noise);
    glbk_texture_destroy(ctx, &r->materials);
    glbk_buffer_destroy(ctx, &r->frame);
    glbk_buffer_destroy(ctx, &r->object);
    glbk_buffer_destroy(ctx, &r->counts);
    for (i = 0; i < 2; i++) glbk_buffer_destroy(ctx, &r->open[i]);
    glbk_buffer_destroy(ctx, &r->wanted);
    glbk_buffer_destroy(ctx, &r->marks);
    memset(r, 0, sizeof *r);
}

/* Rows of width texels of RGBA32F from count items of n floats. */
static glbk_result glbk__rsm_table(glbk_context *ctx, const float *from, uint32_t count, uint32_t n, uint32_t width,
                                   glbk_texture *out)
{
    glbk__allocator memory = glbk__memory(ctx);
    uint32_t rows = (count + width - 1) / width, i;
    glbk_texture_desc d;
    glbk_result result;
    float *texels = (float *)glbk__alloc_array(&memory, (size_t)width * rows, 16);
    if (!texels) return GLBK_ERR_ALLOC;
    memset(texels, 0, (size_t)width * rows * 16);
    for (i = 0; i < count; i++) memcpy(texels + 4 * (size_t)i, from + n * (size_t)i, n * sizeof *from);
    memset(&d, 0, sizeof d);
    d.format = GLBK_FORMAT_RGBA32F;
    d.width = width;
    d.height = rows;
    d.data = texels;
    result = glbk_texture_create(ctx, &d, out);
    glbk__free(&memory, texels);
    return result;
}

GLBK_DEF glbk_result glbk_rsm_tables_upload(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_rsm_tables *t)
{
    glbk_result result = GLBK_OK;

    if (!ctx || !r || !r->frame.name || !t) return GLBK_ERR_ARGUMENT;
    if ((t->points != NULL) != (t->point_count > 0) || (t->noise != NULL) != (t->noise_side > 0))
        return GLBK_ERR_ARGUMENT;
    if ((t->materials != NULL) != (t->material_count > 0)) return GLBK_ERR_ARGUMENT;
    if (t->point_count > 1u << 20 || t->noise_side > 1024 || t->material_count > 1024) return GLBK_ERR_LIMIT;
    glbk_texture_destroy(ctx, &r->pattern);
    glbk_texture_destroy(ctx, &r->noise);
    glbk_texture_destroy(ctx, &r->materials);
    r->points = r->noise_side = r->material_count = 0;
    if (t->points) result = glbk__rsm_table(ctx, t->points, t->point_count, 3, 1024, &r->pattern);
    if (result == GLBK_OK) r->points = t->point_count;
    if (result == GLBK_OK && t->noise)
        result = glbk__rsm_table(ctx, t->noise, t->noise_side * t->noise_side, 1, t->noise_side, &r->noise);
    if (result == GLBK_OK) r->noise_side = t->noise_side;
    if (result == GLBK_OK && t->materials)
        result = glbk__rsm_table(ctx, t->materials, t->material_count, 4, 1024, &r->materials);
    if (result == GLBK_OK) r->material_count = t->material_count;
    return result;
}

/* A program, compiled when it is first asked for. */
static glbk_result glbk__rsm_program(glbk_context *ctx, glbk_rsm_renderer *r, int which)
{
    if (r->programs[which].name) return GLBK_OK;
    return glbk_program_create(ctx, glbk__rsm_programs[which][0], glbk__rsm_programs[which][1], &r->programs[which]);
}

/* A program and r->values as its block; all that a dispatch needs but for textures, images and lists. */
static glbk_result glbk__rsm_ready(glbk_context *ctx, glbk_rsm_renderer *r, int which)
{
    glbk_result result = glbk__rsm_program(ctx, r, which);
    return result == GLBK_OK ? glbk__put_block(ctx, GLBK_SLOT_glbk_rsm_frame, &r->frame, &r->values) : result;
}

/* Begins a pass over width x height pixels of a target; textures are bound after it. */
static glbk_result glbk__rsm_begin(glbk_context *ctx, glbk_rsm_renderer *r, int which, const glbk_target *target,
                                   uint32_t width, uint32_t height)
{
    glbk_pass pass;
    glbk_result result = glbk__rsm_ready(ctx, r, which);
    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    pass.viewport[2] = (int32_t)width;
    pass.viewport[3] = (int32_t)height;
    return glbk_begin(ctx, &pass, &r->programs[which]);
}

static void glbk__rsm_bind_map(glbk_context *ctx, const glbk_rsm_map *map)
{
    glbk_bind_block(ctx, GLBK_SLOT_glbk_rsm_light, &map->light);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_texels, &map->texels);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sums, &map->sums[map->sums_at]);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_rows, &map->rows[map->rows_at]);
}

GLBK_DEF void glbk_rsm_bind(glbk_context *ctx, const glbk_rsm_renderer *r, const glbk_rsm_map *map)
{
    if (!ctx) return;
    if (map) glbk__rsm_bind_map(ctx, map);
    if (!r) return;
    glbk_bind_block(ctx, GLBK_SLOT_glbk_rsm_frame, &r->frame);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_lights, &r->lights);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_pattern, &r->pattern);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_noise, &r->noise);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_materials, &r->materials);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_seen, &r->seen[r->now]);
}

/* ---- >>rsm: drawing maps and the G-buffer ---- */

GLBK_DEF glbk_result glbk_rsm_object(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_rsm_surface *s)
{
    glbk_result result;
    if (!ctx || !r || !r->drawing || !s) return GLBK_ERR_ARGUMENT;
    memcpy(r->drawn.world, s->transform, sizeof r->drawn.world);
    memcpy(r->drawn.albedo, s->albedo, sizeof s->albedo);
    r->drawn.albedo[3] = s->alpha_cutoff;
    r->drawn.kinds[0] = s->material;
    r->drawn.kinds[1] = s->albedo_map != NULL;
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_rsm_drawn, &r->object, &r->drawn);
    if (result != GLBK_OK) {
        if (r->failed == GLBK_OK) r->failed = result;
        return result;
    }
    if (s->albedo_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_albedo_map, s->albedo_map);
    return GLBK_OK;
}

/* Clears a target of three images and has the user draw into it. map: whose face, or NULL. */
static glbk_result glbk__rsm_fill(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_target *target,
                                  const glbk_rsm_map *map, glbk_rsm_draw draw, void *user)
{
    static const uint32_t empty[4] = { 0, 0, 0, 0 }, place[4] = { 0, 0, 0, 0x7f61b1e6u /* RSM_FAR */ };
    int which = map ? GLBK__RSM_FILL_LIGHT : GLBK__RSM_FILL_VIEW;
    glbk_pass pass;
    glbk_result result = glbk__rsm_program(ctx, r, which);
    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_begin(ctx, &pass, &r->programs[which]);
    if (result != GLBK_OK) return result;
    ctx->gl.ClearBufferuiv(GLBK_GL_COLOR, 0, map ? place : empty);
    ctx->gl.ClearBufferuiv(GLBK_GL_COLOR, 1, empty);
    ctx->gl.ClearBufferuiv(GLBK_GL_COLOR, 2, empty);
    glbk_clear_depth(ctx, 1);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_rsm_light, map ? &map->light : &r->frame);    /* not read, but declared */
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_albedo_map, NULL);        /* until an object has one */
    r->drawing = 1;
    r->failed = GLBK_OK;
    draw(user, ctx, r);
    r->drawing = 0;
    return r->failed != GLBK_OK ? r->failed : ctx->lost ? GLBK_ERR_LOST : glbk__leave_frame(ctx);
}

GLBK_DEF glbk_result glbk_rsm_map_draw(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map, glbk_rsm_draw draw,
                                       void *user)
{
    glbk_result result = GLBK_OK;
    uint32_t face;

    if (!ctx || !r || !r->frame.name || !map || !map->texels.name || !draw) return GLBK_ERR_ARGUMENT;
    memset(&r->drawn, 0, sizeof r->drawn);
    if (map->lamp.kind == GLBK_RSM_SUN)
        glbk__rsm_set4(r->drawn.eye, glbk__v3_scale(glbk__v3_load(map->block.axis), -1), 0);
    else glbk__rsm_set4(r->drawn.eye, glbk__v3_load(map->lamp.position), 1);
    r->drawn.range[0] = map->lamp.near_depth;
    r->drawn.range[1] = 1.0f / (map->lamp.far_depth - map->lamp.near_depth);
    map->summed = 0;
    for (face = 0; face < map->faces && result == GLBK_OK; face++) {
        glbk_rsm_map_matrix(map, face, r->drawn.clip);
        r->drawn.kinds[2] = face;
        result = glbk__rsm_fill(ctx, r, &map->faces_drawn[face], map, draw, user);
    }
    return result;
}

/* The filter keeps what the last frame saw: the first filling after it goes to the other G-buffer. */
static void glbk__rsm_turn(glbk_rsm_renderer *r)
{
    if (!r->turn) return;
    r->now = 1 - r->now;
    r->turn = 0;
}

GLBK_DEF glbk_result glbk_rsm_gbuffer_draw(glbk_context *ctx, glbk_rsm_renderer *r, const float world_to_clip[16],
                                           const float eye[3], glbk_rsm_draw draw, void *user)
{
    if (!ctx || !r || !r->frame.name || !world_to_clip || !eye || !draw) return GLBK_ERR_ARGUMENT;
    glbk__rsm_turn(r);
    memset(&r->drawn, 0, sizeof r->drawn);
    memcpy(r->drawn.clip, world_to_clip, sizeof r->drawn.clip);
    glbk__rsm_set4(r->drawn.eye, glbk__v3_load(eye), 1);
    return glbk__rsm_fill(ctx, r, &r->seen_targets[r->now], NULL, draw, user);
}

GLBK_DEF glbk_result glbk_rsm_gbuffer_upload(glbk_context *ctx, glbk_rsm_renderer *r, uint32_t row, uint32_t rows,
                                             const glbk_rsm_pixel *pixels)
{
    glbk__allocator memory;
    float *words;
    size_t count, i;
    uint32_t k;
    glbk_result result = GLBK_OK;

    if (!ctx || !r || !r->frame.name || !rows || row >= r->height || rows > r->height - row || !pixels)
        return GLBK_ERR_ARGUMENT;
    memory = glbk__memory(ctx);
    count = (size_t)r->width * rows;
    words = (float *)glbk__alloc_array(&memory, count, 16);
    if (!words) return GLBK_ERR_ALLOC;
    glbk__rsm_turn(r);
    for (k = 0; k < 3 && result == GLBK_OK; k++) {
        for (i = 0; i < count; i++) {
            memcpy(words + 4 * i, k == 0 ? pixels[i].position : k == 1 ? pixels[i].normal : pixels[i].albedo, 12);
            words[4 * i + 3] = k == 0 ? pixels[i].occlusion : 0.0f;
        }
        result = glbk_texture_update(ctx, &r->seen[r->now], 0, 0, row, k, r->width, rows, 1, words);
    }
    glbk__free(&memory, words);
    return result;
}

/* ---- >>rsm: light ---- */

static int glbk__rsm_maps_valid(const glbk_rsm_map *const *maps, uint32_t count)
{
    uint32_t i;
    if (!maps || !count) return 0;
    for (i = 0; i < count; i++)
        if (!maps[i] || !maps[i]->texels.name) return 0;
    return 1;
}

/* Of the three pictures one that is neither a nor b. */
static uint32_t glbk__rsm_other(uint32_t a, uint32_t b)
{
    uint32_t i = 0;
    while (i == a || i == b) i++;
    return i;
}

GLBK_DEF glbk_result glbk_rsm_direct(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_rsm_map *const *maps,
                                     uint32_t count, const glbk_rsm_direct_desc *d)
{
    uint32_t now = GLBK__RSM_NONE, next, i;
    glbk_result result;

    if (!ctx || !r || !r->frame.name || !glbk__rsm_maps_valid(maps, count) || !d || d->taps > 15)
        return GLBK_ERR_ARGUMENT;
    if (!(d->bias >= 0.0f && d->bias <= 1e6f && d->slope_bias >= 0.0f && d->slope_bias <= 1e6f))
        return GLBK_ERR_ARGUMENT;
    memset(&r->values, 0, sizeof r->values);
    r->values.counts[0] = d->taps ? d->taps : 2;
    r->values.limits[0] = d->bias;
    r->values.limits[1] = d->slope_bias;
    r->direct = GLBK__RSM_NONE;
    for (i = 0; i < count; i++) {
        next = glbk__rsm_other(r->bounce, now);
        r->values.range[3] = i > 0;
        result = glbk__rsm_begin(ctx, r, GLBK__RSM_DIRECT, &r->targets[next], r->width, r->height);
        if (result != GLBK_OK) return result;
        glbk_rsm_bind(ctx, r, maps[i]);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sum, &r->sums[now < 3 ? now : glbk__rsm_other(next, next)]);
        glbk_draw_screen(ctx);
        now = next;
    }
    r->direct = now;
    return GLBK_OK;
}

/* Steps of a running sum along x in all faces of a map: the first from `from`, the others from what is there. */
static glbk_result glbk__rsm_scan(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map, int from, uint32_t height,
                                  glbk_target targets[2][6], int *at)
{
    uint32_t stride, face;
    int next = 0;
    for (stride = 1; stride < map->size; stride *= 8) {
        for (face = 0; face < map->faces; face++) {
            glbk_result result;
            r->values.pick[0] = face;
            r->values.pick[1] = stride;
            result = glbk__rsm_begin(ctx, r, stride == 1 ? from : from + 1, &targets[next][face], map->size, height);
            if (result != GLBK_OK) return result;
            glbk__rsm_bind_map(ctx, map);
            if (stride == 1 && from == GLBK__RSM_SCAN) glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sums, NULL);
            glbk_draw_screen(ctx);
        }
        *at = next;
        next = 1 - next;
    }
    return GLBK_OK;
}

/* The same by a group a row of all faces; then a group a face. */
static glbk_result glbk__rsm_do_sum(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map)
{
    int rows;
    map->sums_at = map->rows_at = 0;
    for (rows = 0; rows < 2; rows++) {
        glbk_result result = glbk__rsm_ready(ctx, r, GLBK__RSM_DO_SCAN + rows);
        if (result != GLBK_OK) return result;
        glbk__rsm_bind_map(ctx, map);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_rsm_running, rows ? &map->rows[0] : &map->sums[0]);
        result = glbk_dispatch(ctx, &r->programs[GLBK__RSM_DO_SCAN + rows], rows ? 1 : map->size, map->faces, 1);
        if (result != GLBK_OK) return result;
    }
    map->summed = 1;
    return GLBK_OK;
}

static glbk_result glbk__rsm_sum(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map)
{
    glbk_result result;
    if (map->summed) return GLBK_OK;
    if (r->compute) return glbk__rsm_do_sum(ctx, r, map);
    result = glbk__rsm_scan(ctx, r, map, GLBK__RSM_SCAN, map->size, map->sum_targets, &map->sums_at);
    if (result == GLBK_OK)
        result = glbk__rsm_scan(ctx, r, map, GLBK__RSM_SCAN_ROWS, 1, map->row_targets, &map->rows_at);
    map->summed = result == GLBK_OK;
    return result;
}

typedef struct glbk__rsm_run {      /* one glbk_rsm_gather */
    glbk_context         *ctx;
    glbk_rsm_renderer    *r;
    glbk_rsm_map *const  *maps;
    uint32_t              count, sets, by_flux, about, room;    /* lights of a map by flux, points about the receiver */
    int mixed, all, apart, listed; /* apart: a list a map; listed: it holds all that is needed */
    uint32_t              seed;
    glbk_texture         *pictures;                             /* where it adds up */
    glbk_target          *targets;
    uint32_t              width, height, now, kept;             /* kept: a picture that must stay */
    const glbk_texture   *states, *coarse;
    const glbk_buffer    *items;                                /* compute: the pixels, or NULL: all */
    int                   begun;
} glbk__rsm_run;

/* Lights first .. of a map into places from .. to - 1 of each set of the list. */
static glbk_result glbk__rsm_pick(glbk__rsm_run *g, const glbk_rsm_map *map, uint32_t lights, uint32_t first,
                                  uint32_t from, uint32_t to)
{
    glbk_rsm_renderer *r = g->r;
    glbk_result result;
    uint32_t last = (g->sets - 1) * r->values.range[2] + to, rows = (last + 1023) / 1024;
    r->values.range[0] = from;
    r->values.range[1] = to;
    r->values.pick[0] = g->seed;
    r->values.pick[1] = lights;
    r->values.pick[2] = first;
    result = glbk__rsm_begin(g->ctx, r, g->all ? GLBK__RSM_PICK_ALL : GLBK__RSM_PICK, &r->lights_target, 1024, rows);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_map(g->ctx, map);
    glbk_draw_screen(g->ctx);
    return GLBK_OK;
}

/* What glbk__rsm_add does, in place: on all pixels of the picture, or on those of a list. */
static glbk_result glbk__rsm_do_add(glbk__rsm_run *g, const glbk_rsm_map *map)
{
    glbk_rsm_renderer *r = g->r;
    int which = r->values.mode[0] == 1 ? GLBK__RSM_DO_NODES : GLBK__RSM_DO_GATHER;
    glbk_program *program;
    uint32_t side = 8 * r->values.counts[1];            /* pixels of a set lie `interleave` apart */
    glbk_result result;
    if (r->values.surfaces[0] > 0.0f) which += GLBK__RSM_DO_GATHER_SURFACES - GLBK__RSM_DO_GATHER;
    program = &r->programs[which];
    result = glbk__rsm_ready(g->ctx, r, which);
    if (result != GLBK_OK) return result;
    glbk_rsm_bind(g->ctx, r, map);
    glbk_bind_image(g->ctx, GLBK_SLOT_glbk_rsm_picture, &r->sums[g->now]);
    g->begun = 1;
    if (!g->items)
        return glbk_dispatch(g->ctx, program, (r->width + side - 1) / side, (r->height + side - 1) / side, g->sets);
    glbk_bind_image(g->ctx, GLBK_SLOT_glbk_rsm_nodes, &r->grids[0]);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_counts, &r->counts);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_items, g->items);
    return glbk_dispatch_indirect(g->ctx, program, &r->counts, 16 * (size_t)r->values.lists[0]);
}

/* Adds the first `listed` lights of each set and the points about the receiver to the picture. */
static glbk_result glbk__rsm_add(glbk__rsm_run *g, const glbk_rsm_map *map, uint32_t listed, uint32_t about)
{
    glbk_rsm_renderer *r = g->r;
    uint32_t next = glbk__rsm_other(g->kept, g->now);
    const glbk_texture *spare;
    float size = (float)map->size;
    glbk_result result;
    r->values.range[0] = 0;
    r->values.range[1] = listed;
    r->values.range[3] = (uint32_t)g->begun;
    r->values.counts[2] = about / g->sets;
    r->values.pattern[1] =
        g->mixed ? (float)g->about * 0.02764f * (map->faces == 1 ? 1.0f : 0.5236f) / (size * size) : 0.0f;
    if (r->compute) return glbk__rsm_do_add(g, map);
    result = glbk__rsm_begin(g->ctx, r, r->values.surfaces[0] > 0.0f ? GLBK__RSM_GATHER_SURFACES : GLBK__RSM_GATHER,
                             &g->targets[next], g->width, g->height);
    if (result != GLBK_OK) return result;
    glbk_rsm_bind(g->ctx, r, map);
    /* Something of the right kind in every slot: software drivers compile a shader anew for each combination. */
    spare = &g->pictures[g->now < 3 ? g->now : glbk__rsm_other(next, next)];
    glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_sum, spare);
    glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_states, g->states ? g->states : spare);
    glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_coarse, g->coarse ? g->coarse : spare);
    glbk_draw_screen(g->ctx);
    g->now = next;
    g->begun = 1;
    return GLBK_OK;
}

/* All maps' light on the pixels that the mode in r->values is about. A list takes as many lights as there is room for;
   it is picked once where it holds them all. */
static glbk_result glbk__rsm_evaluate(glbk__rsm_run *g)
{
    uint32_t m, at = 0, flushed = 0;
    glbk_result result = GLBK_OK;
    g->begun = 0;
    for (m = 0; m < g->count && result == GLBK_OK; m++) {
        const glbk_rsm_map *map = g->maps[m];
        uint32_t lights = g->all ? map->size * map->size * map->faces : g->by_flux;
        uint32_t left = lights / g->sets + (lights % g->sets != 0), first = 0;
        while (left && result == GLBK_OK) {
            uint32_t take = left < g->room - at ? left : g->room - at;
            if (!g->listed) result = glbk__rsm_pick(g, map, lights, first, at, at + take);
            at += take;
            first += take;
            left -= take;
            if (at < g->room || result != GLBK_OK || (g->about && !left)) continue;
            result = glbk__rsm_add(g, map, at, 0);
            at = 0;
            flushed++;
        }
        if ((g->about || (g->apart && at)) && result == GLBK_OK) {
            result = glbk__rsm_add(g, map, at, g->about);
            at = 0;
            flushed++;
        }
    }
    if (at && result == GLBK_OK) {
        result = glbk__rsm_add(g, g->maps[0], at, 0);
        flushed++;
    }
    g->listed = flushed == 1;
    return result;
}

static int glbk__rsm_gather_valid(const glbk_rsm_renderer *r, const glbk_rsm_gather_desc *d)
{
    uint32_t k = d->interleave ? d->interleave : 1;
    int about = d->samples && (d->pattern == GLBK_RSM_PATTERN_ABOUT || d->pattern == GLBK_RSM_PATTERN_MIXED);
    if (d->pattern != GLBK_RSM_PATTERN_DEFAULT && d->pattern != GLBK_RSM_PATTERN_FLUX &&
        d->pattern != GLBK_RSM_PATTERN_ABOUT && d->pattern != GLBK_RSM_PATTERN_MIXED)
        return 0;
    if (d->samples > 1u << 20 || k > 8 || (k & (k - 1))) return 0;
    if (about && (!r->points || r->points % (k * k))) return 0;
    if (!(d->r_max >= 0.0f && d->r_max <= 1e3f && d->offset >= 0.0f && d->offset <= 1e9f)) return 0;
    if (!(d->near_field >= 0.0f && d->near_field <= 32.0f)) return 0;
    return d->clamp >= 0.0f && d->clamp <= 1e18f && d->near_limit >= 0.0f && d->near_limit <= 1e6f;
}

static int glbk__rsm_grid_valid(const glbk_rsm_renderer *r, const glbk_rsm_gather_desc *d, glbk_rsm_grid *g)
{
    if (!r->grids[0].name || d->interleave > 1 || r->noise_side) return 0;
    if (!g->step) g->step = 8;
    if (!g->levels) g->levels = 6;
    if (g->step < 2 || g->step > 64 || (g->step & (g->step - 1)) || g->levels > 6) return 0;
    if (!(fabsf(g->normal_cosine) <= 1.0f && g->plane_slope >= 0.0f && g->plane_slope <= 1e6f)) return 0;
    if (!(g->distance >= 0.0f && g->distance <= 1e9f && fabsf(g->contrast) <= 1e6f && fabsf(g->reach) <= 1e6f))
        return 0;
    if (!(fabsf(g->normal_cosine) > 0.0f)) g->normal_cosine = 0.95f;
    if (!(g->plane_slope > 0.0f)) g->plane_slope = 0.05f;
    if (!(fabsf(g->contrast) > 0.0f)) g->contrast = 0.25f;
    if (!(fabsf(g->reach) > 0.0f)) g->reach = 0.25f;
    return 1;
}

/* One pass of compute over all pixels, nodes or open pixels of interpolation. list: number of that with the groups, or
   NULL and x by y of them. */
static glbk_result glbk__rsm_do_lists(glbk__rsm_run *g, int which, uint32_t level, const uint32_t *list, uint32_t x,
                                      uint32_t y)
{
    glbk_rsm_renderer *r = g->r;
    glbk_result result = glbk__rsm_ready(g->ctx, r, which);
    if (result != GLBK_OK) return result;
    glbk_rsm_bind(g->ctx, r, NULL);
    glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_coarse, &r->grids[0]);
    glbk_bind_image(g->ctx, GLBK_SLOT_glbk_rsm_picture, &r->sums[g->now]);
    glbk_bind_image(g->ctx, GLBK_SLOT_glbk_rsm_nodes, &r->grids[0]);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_counts, &r->counts);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_items, &r->open[(level + 1) & 1]);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_left, &r->open[level & 1]);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_wanted, &r->wanted);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_marks, &r->marks);
    return list ? glbk_dispatch_indirect(g->ctx, &r->programs[which], &r->counts, 16 * (size_t)*list)
                : glbk_dispatch(g->ctx, &r->programs[which], x, y, 1);
}

/* Nothing is in the lists, no node of r->grids[0] is evaluated; those of the first grid are wanted. */
static glbk_result glbk__rsm_do_begin(glbk__rsm_run *g, const glbk_rsm_grid *d)
{
    static const uint32_t empty[4] = { 0, 0, 1, 0 };
    glbk_rsm_renderer *r = g->r;
    uint32_t counts[4 * GLBK__RSM_LISTS], i, fine = d->step, nodes[2];
    glbk_result result;
    for (i = 1; i < d->levels && fine > 2; i++) fine /= 2;
    for (i = 0; i < GLBK__RSM_LISTS; i++) memcpy(counts + 4 * i, empty, sizeof empty);
    nodes[0] = (r->width - 1 + fine - 1) / fine + 1;
    nodes[1] = (r->height - 1 + fine - 1) / fine + 1;
    r->values.grid[0] = d->step;
    r->values.grid[1] = fine;
    r->values.lists[2] = 0;
    result =
        glbk__put_values(g->ctx, GLBK_GL_SHADER_STORAGE_BUFFER, GLBK_SLOT_glbk_rsm_counts, &r->counts, counts);
    if (result != GLBK_OK) return result;
    return glbk__rsm_do_lists(g, GLBK__RSM_DO_BEGIN, 0, NULL, (nodes[0] + 7) / 8, (nodes[1] + 7) / 8);
}

/* glbk__rsm_grids by compute. List 2 level holds the nodes to evaluate, 2 level + 1 the pixels that stay open. All
   grids are in one, the finest; the picture gets what is evaluated and what is interpolated at once. */
static glbk_result glbk__rsm_do_grids(glbk__rsm_run *g, const glbk_rsm_grid *d)
{
    glbk_rsm_renderer *r = g->r;
    uint32_t step, level, before = 0;
    glbk_result result;
    g->now = glbk__rsm_other(r->direct, GLBK__RSM_NONE);
    result = glbk__rsm_do_begin(g, d);
    for (step = d->step, level = 0; step > 1 && level < d->levels && result == GLBK_OK; step /= 2, level++) {
        r->values.mode[0] = 1;
        r->values.lists[0] = 2 * level;
        g->items = &r->wanted;
        result = glbk__rsm_evaluate(g);
        if (result != GLBK_OK) return result;
        r->values.grid[0] = step;
        r->values.lists[0] = before;
        r->values.lists[1] = 2 * level + 1;
        r->values.lists[2] = 2 * level + 2;
        r->values.lists[3] = level + 1 < d->levels && step > 2 ? step / 2 : 0;
        result = glbk__rsm_do_lists(g, level ? GLBK__RSM_DO_LISTED : GLBK__RSM_DO_INTERPOLATE, level,
                                    level ? &before : NULL, (r->width + 15) / 16, (r->height + 15) / 16);
        before = 2 * level + 1;
    }
    r->values.mode[0] = 2;
    r->values.lists[0] = before;
    g->items = &r->open[before >> 1 & 1];
    return result;
}

/* Grids of half the step each time, then what is left. Pictures end in r->sums. */
static glbk_result glbk__rsm_grids(glbk__rsm_run *g, const glbk_rsm_grid *d)
{
    glbk_rsm_renderer *r = g->r;
    uint32_t step = d->step, levels = d->levels, picture = GLBK__RSM_NONE, coarse = GLBK__RSM_NONE, next;
    glbk_result result;
    r->values.tests[0] = d->normal_cosine;
    r->values.tests[1] = d->plane_slope;
    r->values.tests[2] = d->distance;
    r->values.tests[3] = d->contrast;
    r->values.pattern[3] = d->reach;
    if (r->compute) return glbk__rsm_do_grids(g, d);
    for (; step > 1 && levels > 0; step /= 2, levels--) {
        r->values.mode[0] = 1;
        r->values.grid[1] = coarse < 3 ? r->values.grid[0] : 0;
        r->values.grid[0] = step;
        g->pictures = r->grids;
        g->targets = r->grid_targets;
        g->width = (r->width - 2 + step) / step + 1;
        g->height = (r->height - 2 + step) / step + 1;
        if (r->width == 1) g->width = 1;
        if (r->height == 1) g->height = 1;
        g->kept = coarse;
        g->now = GLBK__RSM_NONE;
        g->states = picture < 3 ? &r->sums[picture] : NULL;
        g->coarse = coarse < 3 ? &r->grids[coarse] : NULL;
        result = glbk__rsm_evaluate(g);
        if (result != GLBK_OK) return result;
        coarse = g->now;
        next = glbk__rsm_other(r->direct, picture);
        r->values.range[3] = picture < 3;
        result = glbk__rsm_begin(g->ctx, r, GLBK__RSM_INTERPOLATE, &r->targets[next], r->width, r->height);
        if (result != GLBK_OK) return result;
        glbk_rsm_bind(g->ctx, r, NULL);
        glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_sum, picture < 3 ? &r->sums[picture] : NULL);
        glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_coarse, &r->grids[coarse]);
        glbk_draw_screen(g->ctx);
        picture = next;
    }
    r->values.mode[0] = 2;
    g->now = picture;
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_rsm_gather(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *const *maps, uint32_t count,
                                     const glbk_rsm_gather_desc *d, const glbk_rsm_grid *grid)
{
    glbk__rsm_run g;
    glbk_rsm_grid tests;
    glbk_result result = GLBK_OK;
    uint32_t k, i, most;

    memset(&tests, 0, sizeof tests);
    if (!ctx || !r || !r->frame.name || !d || !glbk__rsm_maps_valid((const glbk_rsm_map *const *)maps, count))
        return GLBK_ERR_ARGUMENT;
    if (grid) tests = *grid;
    if (!glbk__rsm_gather_valid(r, d) || (grid && !glbk__rsm_grid_valid(r, d, &tests))) return GLBK_ERR_ARGUMENT;
    memset(&g, 0, sizeof g);
    memset(&r->values, 0, sizeof r->values);
    g.ctx = ctx;
    g.r = r;
    g.maps = maps;
    g.count = count;
    g.seed = d->seed;
    g.all = d->samples == 0;
    g.mixed = d->pattern == GLBK_RSM_PATTERN_MIXED && d->samples > 1;
    g.apart = g.mixed || r->material_count > 0 || (g.all && d->near_field > 0.0f);
    if (!g.all && (g.mixed || d->pattern == GLBK_RSM_PATTERN_ABOUT)) g.about = r->points;
    if (!g.all && d->pattern != GLBK_RSM_PATTERN_ABOUT) g.by_flux = d->samples - (g.mixed ? 3 * d->samples / 5 : 0);
    k = d->interleave ? d->interleave : 1;
    g.sets = k * k;
    most = d->lights_per_pass ? d->lights_per_pass : 4096;
    if (most > GLBK__RSM_LIST / 2) most = GLBK__RSM_LIST / 2;   /* llvmpipe ends a shader's loops at 65,535 rounds */
    g.room = GLBK__RSM_LIST / g.sets < most ? GLBK__RSM_LIST / g.sets : most;
    for (i = 0; i < count && (g.by_flux || g.mixed) && result == GLBK_OK; i++) result = glbk__rsm_sum(ctx, r, maps[i]);
    if (result != GLBK_OK) return result;
    r->values.counts[1] = k;
    r->values.counts[3] = r->noise_side;
    r->values.range[2] = g.room;
    r->values.pick[3] = r->material_count;
    r->values.grid[2] = r->width;
    r->values.grid[3] = r->height;
    r->values.pattern[0] = g.mixed ? 0.0f : d->r_max;
    r->values.limits[0] = d->offset;
    r->values.limits[1] = d->clamp;
    r->values.limits[2] = d->near_limit;
    r->values.limits[3] = (float)g.sets;
    r->values.pattern[2] = g.mixed ? (float)g.by_flux : 0.0f;
    r->values.surfaces[0] = g.all || g.about ? d->near_field : 0.0f;
    r->bounce = g.now = GLBK__RSM_NONE;
    if (grid) result = glbk__rsm_grids(&g, &tests);
    if (result != GLBK_OK) return result;
    g.pictures = r->sums;
    g.targets = r->targets;
    g.kept = r->direct;
    g.width = r->width;
    g.height = r->height;
    g.states = g.coarse = NULL;
    if (r->compute && !grid) g.now = glbk__rsm_other(r->direct, GLBK__RSM_NONE);
    result = glbk__rsm_evaluate(&g);
    if (result == GLBK_OK) r->bounce = g.now;
    return result;
}

/* ---- >>rsm: filter and picture ---- */

/* bounce counts on: 3 and 4 are the histories. */
static const glbk_texture *glbk__rsm_bounced(const glbk_rsm_renderer *r)
{
    return r->bounce < 3 ? &r->sums[r->bounce] : r->bounce < 5 ? &r->history[r->bounce - 3] : NULL;
}

static glbk_result glbk__rsm_smooth(glbk_context *ctx, glbk_rsm_renderer *r, uint32_t passes)
{
    uint32_t pass, next;
    for (pass = 0; pass < passes; pass++) {
        glbk_result result;
        uint32_t step = 1u << pass, side = 16 * step;
        next = glbk__rsm_other(r->direct, r->bounce);
        r->values.grid[0] = step;
        result = r->compute ? glbk__rsm_ready(ctx, r, GLBK__RSM_DO_SMOOTH)
                            : glbk__rsm_begin(ctx, r, GLBK__RSM_SMOOTH, &r->targets[next], r->width, r->height);
        if (result != GLBK_OK) return result;
        glbk_rsm_bind(ctx, r, NULL);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sum, glbk__rsm_bounced(r));
        if (r->compute) {
            glbk_bind_image(ctx, GLBK_SLOT_glbk_rsm_picture, &r->sums[next]);
            result = glbk_dispatch(ctx, &r->programs[GLBK__RSM_DO_SMOOTH], (r->width + side - 1) / side,
                                   (r->height + side - 1) / side, step * step);
            if (result != GLBK_OK) return result;
        } else {
            glbk_draw_screen(ctx);
        }
        r->bounce = next;
    }
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_rsm_denoise(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_rsm_denoise_desc *d)
{
    uint32_t to;
    int i;
    glbk_result result;

    if (!ctx || !r || !r->history[0].name || !d || !glbk__rsm_bounced(r) || r->turn) return GLBK_ERR_ARGUMENT;
    if (d->passes > 6 || d->history > 1000 || !(d->normal_cosine >= 0.0f && d->normal_cosine < 1.0f))
        return GLBK_ERR_ARGUMENT;
    if (!(d->plane_slope >= 0.0f && d->plane_slope <= 1e6f)) return GLBK_ERR_ARGUMENT;
    for (i = 0; i < 16 && d->view_projection; i++)
        if (!(fabsf(d->view_projection[i]) <= 3.0e38f)) return GLBK_ERR_ARGUMENT;
    memset(&r->values, 0, sizeof r->values);
    r->values.grid[2] = r->width;
    r->values.grid[3] = r->height;
    r->values.mode[1] = !r->remembers ? 0u : d->motion ? 2u : d->view_projection && r->has_before ? 1u : 0u;
    r->values.mode[2] = d->top_first != 0;
    r->values.pattern[3] = (float)(d->history ? d->history : 8);
    r->values.tests[0] = d->normal_cosine > 0.0f ? d->normal_cosine : 0.9f;
    r->values.tests[1] = d->plane_slope > 0.0f ? d->plane_slope : 0.1f;
    memcpy(r->drawn.clip, r->before, sizeof r->before);
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_rsm_drawn, &r->object, &r->drawn);
    to = r->remembers == 1 ? 1 : 0;
    if (result == GLBK_OK)
        result = glbk__rsm_begin(ctx, r, GLBK__RSM_RECALL, &r->history_targets[to], r->width, r->height);
    if (result != GLBK_OK) return result;
    glbk_rsm_bind(ctx, r, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_before, &r->seen[1 - r->now]);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sum, glbk__rsm_bounced(r));
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_history, &r->history[1 - to]);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_motion, d->motion);
    glbk_draw_screen(ctx);
    r->bounce = 3 + to;
    r->remembers = 1 + to;
    r->turn = 1;
    r->has_before = d->view_projection != NULL;
    if (d->view_projection) memcpy(r->before, d->view_projection, sizeof r->before);
    return glbk__rsm_smooth(ctx, r, d->passes);
}

GLBK_DEF void glbk_rsm_forget(glbk_rsm_renderer *r)
{
    if (r) r->remembers = 0;
}

GLBK_DEF glbk_result glbk_rsm_resolve(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_pass *pass, int direct,
                                      int bounced)
{
    glbk_result result;

    if (!ctx || !r || !r->frame.name || !pass) return GLBK_ERR_ARGUMENT;
    memset(&r->values, 0, sizeof r->values);
    r->values.mode[0] = direct && r->direct < 3;
    r->values.mode[1] = bounced && glbk__rsm_bounced(r);
    result = glbk__corner(ctx, pass, r->width, r->height, r->values.range);
    if (result == GLBK_OK) result = glbk__rsm_program(ctx, r, GLBK__RSM_RESOLVE);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_rsm_frame, &r->frame, &r->values);
    if (result == GLBK_OK) result = glbk_begin(ctx, pass, &r->programs[GLBK__RSM_RESOLVE]);
    if (result != GLBK_OK) return result;
    glbk_rsm_bind(ctx, r, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sum, r->direct < 3 ? &r->sums[r->direct] : NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_states, glbk__rsm_bounced(r));
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_rsm_read(glbk_context *ctx, glbk_rsm_renderer *r, int bounced, float *rgba)
{
    const glbk_target *target;
    if (!ctx || !r || !rgba) return GLBK_ERR_ARGUMENT;
    if (bounced)
        target = r->bounce < 3 ? &r->targets[r->bounce] : r->bounce < 5 ? &r->history_targets[r->bounce - 3] : NULL;
    else target = r->direct < 3 ? &r->targets[r->direct] : NULL;
    return target ? glbk_target_read(ctx, target, 0, 0, 0, r->width, r->height, rgba) : GLBK_ERR_ARGUMENT;
}

/* ---- end of rsm ---- */

/* ---- >>ism ---- */

static int glbk__ism_resolve(glbk_ism_desc *d)
{
    if (d->vpl_count > 16384 || (d->points && d->points < 8) || d->points > 65536 || d->projection > 4 ||
        d->lazy > 64 || d->near_points > 64 ||
        (d->tile_size && (d->tile_size < 8 || d->tile_size > 256 || (d->tile_size & (d->tile_size - 1)))) ||
        !(d->splat_scale >= 0 && d->splat_scale <= 16) || d->window_rim == 1 ||
        d->window_rim > (d->tile_size ? d->tile_size : 64) / 2)
        return 0;
    if (!d->vpl_count) d->vpl_count = 1024;
    if (!d->points) d->points = 8192;
    if (!d->tile_size) d->tile_size = 64;
    if (!d->window_rim) d->window_rim = d->tile_size < 16 ? 2 : d->tile_size / 8;
    if (!d->projection) d->projection = 1;
    if (!d->lazy) d->lazy = 8;
    if (!d->near_points) d->near_points = 16;
    if (!(d->splat_scale > 0)) d->splat_scale = 1.0f;
    if (!d->points_per_pass) d->points_per_pass = 1u << 20;
    return 1;
}

/* What both paths draw: surfels, the atlas. */
static glbk_result glbk__ism_create_canvases(glbk_context *ctx, glbk_ism_maps *m)
{
    const glbk_texture *depth = NULL;
    glbk_texture_desc d;
    glbk_result result = GLBK_OK;
    memset(&d, 0, sizeof d);
    d.format = GLBK_FORMAT_DEPTH32F;
    d.width = d.height = m->side;
    if (!m->compute) {
        result = glbk_texture_create(ctx, &d, &m->depth);
        depth = &m->depth;
    }
    if (result == GLBK_OK)
        result = glbk__canvas(ctx, GLBK_FORMAT_COLOR, m->side, m->side, depth, &m->surfels, &m->surfel_target);
    return result == GLBK_OK ? glbk__canvas(ctx, GLBK_FORMAT_R32UI, m->side, m->side, NULL, &m->atlas, &m->atlas_target)
                             : result;
}

/* What the core path needs from surfels to the atlas. */
static glbk_result glbk__ism_create_fill(glbk_context *ctx, glbk_ism_maps *m, const char *projection)
{
    char defines[] = "ISM_LEVEL=1";
    glbk_result result = glbk__canvas(ctx, GLBK_FORMAT_R8UI, m->side, m->side, NULL, &m->kept, &m->kept_target);
    uint32_t i;
    if (result == GLBK_OK) result = glbk_program_create(ctx, "ism_holes.frag", projection, &m->holes);
    for (i = 0; i < GLBK_ISM_LEVELS && result == GLBK_OK; i++) {
        result = glbk__canvas(ctx, GLBK_FORMAT_R32UI, m->side >> (i + 1), m->side >> (i + 1), NULL, &m->pull[i],
                              &m->pull_target[i]);
        defines[10] = (char)('1' + (int)i);
        if (result == GLBK_OK) result = glbk_program_create(ctx, "ism_pull.frag", defines, &m->pull_program[i]);
    }
    return result == GLBK_OK ? glbk_program_create(ctx, "ism_push.frag", projection, &m->push) : result;
}

static glbk_result glbk__ism_create_programs(glbk_context *ctx, glbk_ism_maps *m)
{
    char defines[] = "ISM_PROJECTION=1 ISM_QUADS=0";
    glbk_result result;
    m->quads = !m->compute && ctx->max_point_size < (float)m->desc.tile_size;
    defines[15] = (char)('0' + (int)m->desc.projection);
    defines[27] = m->quads ? '1' : '0';
    result = glbk_program_create(ctx, m->compute ? "ism_splat.comp" : "ism_splat.frag", defines, &m->splat);
    if (result != GLBK_OK) return result;
    if (!m->compute) return glbk__ism_create_fill(ctx, m, defines);
    return glbk_program_create(ctx, "ism_fill.comp", defines, &m->fill);
}

/* Levels of pull and push: the coarsest has two cells a side of a tile at least. */
static uint32_t glbk__ism_levels(const glbk_ism_maps *m)
{
    uint32_t levels = m->desc.no_fill ? 0 : GLBK_ISM_LEVELS;
    while (levels && m->desc.tile_size >> levels < 2) levels--;
    return levels;
}

/* Texels of the table of VPLs before the near points' spheres, and of these. */
static uint32_t glbk__ism_vpl_texels(const glbk_ism_maps *m) { return 4 * m->desc.vpl_count; }
static uint32_t glbk__ism_spheres(const glbk_ism_maps *m)
{
    return (m->desc.vpl_count * m->desc.near_points + 63) / 64;
}

static glbk_ism_frame glbk__ism_frame_of(const glbk_ism_maps *m)
{
    glbk_ism_frame f;
    memset(&f, 0, sizeof f);
    f.maps[0] = m->count;
    f.maps[1] = m->desc.tile_size;
    f.maps[2] = m->tiles;
    f.maps[3] = m->each * m->desc.lazy;
    f.points[0] = m->desc.vpl_count;
    f.points[1] = m->each;
    f.points[2] = glbk__ism_levels(m);
    f.points[3] = m->triangles;
    memcpy(f.sphere, m->sphere, sizeof f.sphere);
    f.values[0] = m->desc.splat_scale;
    f.values[1] = (float)m->desc.window_rim;
    f.near_points[0] = m->near_count;
    f.near_points[1] = glbk__ism_vpl_texels(m);
    f.near_points[2] = f.near_points[1] + glbk__ism_spheres(m);
    return f;
}

static glbk_result glbk__ism_write_frame(glbk_context *ctx, const glbk_ism_maps *m)
{
    const glbk_ism_frame f = glbk__ism_frame_of(m);
    return glbk_buffer_update(ctx, &m->frame, 0, sizeof f, &f);
}

/* By compute one table, since a dispatch reads all phases. Else one for each: it is written while the frame before may
   still be drawn, and GPUs that keep frames in flight copy the whole of a texture that is. */
static glbk_result glbk__ism_create_points(glbk_context *ctx, glbk_ism_maps *m, size_t points)
{
    glbk_result result = GLBK_OK;
    uint32_t i;
    if (m->compute) return glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, points, &m->points);
    for (i = 0; i < m->desc.lazy && result == GLBK_OK; i++)
        result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, points / m->desc.lazy, &m->phase_points[i]);
    return result;
}

GLBK_DEF glbk_result glbk_ism_maps_create(glbk_context *ctx, const glbk_ism_desc *desc, glbk_ism_maps *out)
{
    static const uint32_t nothing[4] = { 0, 0, 0, 0 };
    size_t points;
    glbk_result result;
    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (desc) out->desc = *desc;
    if (!glbk__ism_resolve(&out->desc)) return memset(out, 0, sizeof *out), GLBK_ERR_ARGUMENT;
    for (out->tiles = 1; out->tiles * out->tiles < out->desc.vpl_count; out->tiles++) {}
    out->side = out->tiles * out->desc.tile_size;
    out->each = (out->desc.points + out->desc.lazy - 1) / out->desc.lazy;
    points = (size_t)out->each * out->desc.lazy * out->desc.vpl_count;
    if (out->side > ctx->max_size || points > 0x7fffffff) return memset(out, 0, sizeof *out), GLBK_ERR_LIMIT;
    out->compute = ctx->compute && out->each * out->desc.lazy <= 65536;     /* ism_splat.comp counts them in 16 bits */
    result = glbk__ism_create_points(ctx, out, points);
    if (result == GLBK_OK)
        result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32F, NULL,
                                   glbk__ism_vpl_texels(out) + glbk__ism_spheres(out) +
                                       3 * (size_t)out->desc.vpl_count * out->desc.near_points, &out->vpls);
    if (result == GLBK_OK) result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, nothing, 1, &out->triangle_table);
    if (result == GLBK_OK) result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32F, nothing, 1, &out->positions);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_ism_frame), NULL, &out->frame);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_ism_view), NULL, &out->view);
    if (result == GLBK_OK) result = glbk__ism_create_canvases(ctx, out);
    if (result == GLBK_OK) result = glbk__ism_create_programs(ctx, out);
    if (result == GLBK_OK) result = glbk__made(ctx, glbk__ism_write_frame(ctx, out));
    if (result != GLBK_OK) glbk_ism_maps_destroy(ctx, out);
    return result;
}

GLBK_DEF void glbk_ism_maps_destroy(glbk_context *ctx, glbk_ism_maps *m)
{
    uint32_t i;
    if (!m) return;
    for (i = 0; i < GLBK_ISM_LEVELS; i++) {
        glbk_program_destroy(ctx, &m->pull_program[i]);
        glbk_target_destroy(ctx, &m->pull_target[i]);
        glbk_texture_destroy(ctx, &m->pull[i]);
    }
    glbk_program_destroy(ctx, &m->splat);
    glbk_program_destroy(ctx, &m->holes);
    glbk_program_destroy(ctx, &m->push);
    glbk_program_destroy(ctx, &m->fill);
    glbk_target_destroy(ctx, &m->surfel_target);
    glbk_target_destroy(ctx, &m->kept_target);
    glbk_target_destroy(ctx, &m->atlas_target);
    glbk_texture_destroy(ctx, &m->vpls);
    glbk_texture_destroy(ctx, &m->points);
    for (i = 0; i < 64; i++) glbk_texture_destroy(ctx, &m->phase_points[i]);
    glbk_texture_destroy(ctx, &m->triangle_table);
    glbk_texture_destroy(ctx, &m->positions);
    glbk_texture_destroy(ctx, &m->surfels);
    glbk_texture_destroy(ctx, &m->depth);
    glbk_texture_destroy(ctx, &m->kept);
    glbk_texture_destroy(ctx, &m->atlas);
    glbk_buffer_destroy(ctx, &m->frame);
    glbk_buffer_destroy(ctx, &m->view);
    memset(m, 0, sizeof *m);
}


/* count strided triples into a table of four floats each, at least one texel; the table is made anew where it is too
 * small. */
static glbk_result glbk__ism_upload(glbk_context *ctx, glbk_texture *table, uint32_t had, const float *from,
                                    size_t count, size_t stride)
{
    glbk__allocator memory = glbk__memory(ctx);
    float *texels = (float *)glbk__alloc_array(&memory, count ? count : 1, 16);
    glbk_texture made;
    glbk_result result;
    size_t i;
    if (!texels) return GLBK_ERR_ALLOC;
    memset(texels, 0, 16 * (count ? count : 1));
    for (i = 0; i < count; i++) memcpy(texels + 4 * i, (const char *)from + (stride ? stride : 12) * i, 12);
    if (table->name && count == had && count) {
        result = glbk_table_update(ctx, table, 0, count, texels);
    } else {
        result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32F, texels, count ? count : 1, &made);
        if (result == GLBK_OK) {
            glbk_texture_destroy(ctx, table);
            *table = made;
        }
    }
    glbk__free(&memory, texels);
    return result;
}

/* Three indices and the bits of the opacity, or NULL where memory (result) or an index (its error) fails. */
static uint32_t *glbk__ism_triangles(const glbk__allocator *memory, const glbk_ism_mesh *mesh, size_t count,
                                     glbk_result *result)
{
    uint32_t *words = (uint32_t *)glbk__alloc_array(memory, count, 16);
    float opacity = 1;
    size_t i, k;
    *result = words ? GLBK_OK : GLBK_ERR_ALLOC;
    for (i = 0; i < count && *result == GLBK_OK; i++) {
        for (k = 0; k < 3; k++) {
            words[4 * i + k] = mesh->indices ? mesh->indices[3 * i + k] : (uint32_t)(3 * i + k);
            if (words[4 * i + k] >= mesh->vertex_count) *result = GLBK_ERR_ARGUMENT;
        }
        if (mesh->opacities) opacity = mesh->opacities[i];
        memcpy(words + 4 * i + 3, &opacity, 4);
    }
    if (words && *result != GLBK_OK) {
        glbk__free(memory, words);
        words = NULL;
    }
    return words;
}

GLBK_DEF glbk_result glbk_ism_mesh_upload(glbk_context *ctx, glbk_ism_maps *m, const glbk_ism_mesh *mesh)
{
    glbk__allocator memory;
    uint32_t *words;
    size_t corners = mesh ? (mesh->indices ? mesh->index_count : mesh->vertex_count) : 0, count = corners / 3;
    glbk_texture made;
    glbk_result result;
    if (!ctx || !m || !m->vpls.name || (mesh && !glbk__stride_valid(mesh->vertex_stride, 12)) || corners % 3 ||
        (corners && !mesh->positions))
        return GLBK_ERR_ARGUMENT;
    if (corners > 0x7fffffff || (mesh && mesh->vertex_count > 0x7fffffff)) return GLBK_ERR_LIMIT;
    if (count) {
        memory = glbk__memory(ctx);
        words = glbk__ism_triangles(&memory, mesh, count, &result);
        if (!words) return result;
        result = glbk_table_create(ctx, GLBK_FORMAT_RGBA32UI, words, count, &made);
        glbk__free(&memory, words);
        if (result == GLBK_OK) {
            result = glbk__ism_upload(ctx, &m->positions, m->vertices, mesh->positions, mesh->vertex_count,
                                      mesh->vertex_stride);
            if (result != GLBK_OK) glbk_texture_destroy(ctx, &made);
        }
        if (result != GLBK_OK) return result;
        glbk_texture_destroy(ctx, &m->triangle_table);
        m->triangle_table = made;
        m->vertices = (uint32_t)mesh->vertex_count;
    }
    if (count != m->triangles) m->phases = 0;
    m->triangles = (uint32_t)count;
    return glbk__made(ctx, glbk__ism_write_frame(ctx, m));
}

GLBK_DEF glbk_result glbk_ism_mesh_move(glbk_context *ctx, glbk_ism_maps *m, const float *positions, size_t stride)
{
    if (!ctx || !m || !m->triangles || !positions || !glbk__stride_valid(stride, 12)) return GLBK_ERR_ARGUMENT;
    return glbk__ism_upload(ctx, &m->positions, m->vertices, positions, m->vertices, stride);
}

GLBK_DEF glbk_result glbk_ism_phase(glbk_context *ctx, glbk_ism_maps *m, uint32_t phase, const void *points)
{
    size_t count;
    glbk_result result;
    if (!ctx || !m || !m->vpls.name || !points || phase >= m->desc.lazy) return GLBK_ERR_ARGUMENT;
    count = (size_t)m->desc.vpl_count * m->each;
    result = m->compute ? glbk_table_update(ctx, &m->points, count * phase, count, points)
                        : glbk_table_update(ctx, &m->phase_points[phase], 0, count, points);
    if (result == GLBK_OK) m->phases |= (uint64_t)1 << phase;
    return result;
}

static int glbk__ism_vpl_ok(const glbk_ism_vpl *v)
{
    float sum = v->exponent + v->side + v->reach;
    int k;
    for (k = 0; k < 3; k++) sum += v->position[k] * 0 + v->normal[k] * 0 + v->flux[k] * 0 + v->axis[k] * 0;
    for (k = 0; k < 2; k++)         /* something is left of each side */
        if ((v->window >> 6 * k & 63) + (v->window >> (6 * k + 12) & 63) > 63) return 0;
    return sum >= 0 && v->exponent >= 0 && v->exponent <= 1e5f && v->side >= 0 && v->reach >= 0 &&
           sum < 3e38f && v->window < 1u << 24;
}

GLBK_DEF glbk_result glbk_ism_vpls_upload(glbk_context *ctx, glbk_ism_maps *m, const glbk_ism_vpl *vpls, uint32_t count,
                                          const float center[3], float radius)
{
    glbk__allocator memory;
    glbk_result result = GLBK_OK;
    float *texels;
    uint32_t i;
    if (!ctx || !m || !m->vpls.name || (count && !vpls) || count > m->desc.vpl_count || (center && !(radius > 0)))
        return GLBK_ERR_ARGUMENT;
    for (i = 0; i < count; i++)
        if (!glbk__ism_vpl_ok(&vpls[i]) || (vpls[i].directional && !center)) return GLBK_ERR_ARGUMENT;
    if (count) {
        memory = glbk__memory(ctx);
        texels = (float *)glbk__alloc_array(&memory, count, 64);
        if (!texels) return GLBK_ERR_ALLOC;
        for (i = 0; i < count; i++) {
            float *to = texels + 16 * (size_t)i;
            memcpy(to, vpls[i].position, 12);
            to[3] = vpls[i].directional ? -1 : vpls[i].exponent;
            memcpy(to + 4, vpls[i].normal, 12);
            to[7] = vpls[i].side;
            memcpy(to + 8, vpls[i].flux, 12);
            to[11] = vpls[i].reach;
            memcpy(to + 12, vpls[i].axis, 12);
            to[15] = (float)vpls[i].window;
        }
        result = glbk_table_update(ctx, &m->vpls, 0, 4 * (size_t)count, texels);
        glbk__free(&memory, texels);
    }
    if (result != GLBK_OK) return result;
    m->count = count;
    m->near_count = 0;
    memset(m->sphere, 0, sizeof m->sphere);
    if (center) memcpy(m->sphere, center, 3 * sizeof(float));
    m->sphere[3] = center ? radius : 1;
    return glbk__ism_write_frame(ctx, m);
}

/* x, y, z and radius of the sphere beyond which none of them reaches, as ism.h has it. */
static void glbk__ism_near_sphere(const float *points, uint32_t count, float sphere[4])
{
    float lo[3], hi[3], d2, reach;
    uint32_t i, k;
    for (k = 0; k < 3; k++) lo[k] = hi[k] = points[k];
    for (i = 1; i < count; i++)
        for (k = 0; k < 3; k++) {
            lo[k] = points[12 * i + k] < lo[k] ? points[12 * i + k] : lo[k];
            hi[k] = points[12 * i + k] > hi[k] ? points[12 * i + k] : hi[k];
        }
    for (k = 0; k < 3; k++) sphere[k] = 0.5f * (lo[k] + hi[k]);
    sphere[3] = 0;
    for (i = 0; i < count; i++) {
        for (k = 0, d2 = 0; k < 3; k++) d2 += (points[12 * i + k] - sphere[k]) * (points[12 * i + k] - sphere[k]);
        reach = sqrtf(d2) + points[12 * i + 7];
        if (reach > sphere[3]) sphere[3] = reach;
    }
}

GLBK_DEF glbk_result glbk_ism_near_upload(glbk_context *ctx, glbk_ism_maps *m, const void *points, uint32_t count)
{
    const float *values = (const float *)points;
    glbk__allocator memory;
    glbk_result result;
    float *spheres;
    uint32_t i, k;
    if (!ctx || !m || !m->vpls.name || (count && !points) || count > m->desc.vpl_count * m->desc.near_points)
        return GLBK_ERR_ARGUMENT;
    for (i = 0; i < count; i++) {
        const float *p = values + 12 * (size_t)i;
        float sum = 0;
        for (k = 0; k < 12; k++) sum += p[k] * 0;
        if (!(sum >= 0 && p[3] >= 0 && p[7] >= 0 && p[11] >= 0 && p[11] < (float)m->count)) return GLBK_ERR_ARGUMENT;
    }
    m->near_count = count;
    if (!count) return glbk__ism_write_frame(ctx, m);
    memory = glbk__memory(ctx);
    spheres = (float *)glbk__alloc_array(&memory, (count + 63) / 64, 16);
    if (!spheres) return m->near_count = 0, GLBK_ERR_ALLOC;
    for (i = 0; i < count; i += 64)
        glbk__ism_near_sphere(values + 12 * (size_t)i, count - i < 64 ? count - i : 64, spheres + i / 16);
    result = glbk_table_update(ctx, &m->vpls, glbk__ism_vpl_texels(m), (count + 63) / 64, spheres);
    glbk__free(&memory, spheres);
    if (result == GLBK_OK)
        result = glbk_table_update(ctx, &m->vpls, (size_t)glbk__ism_vpl_texels(m) + glbk__ism_spheres(m),
                                   3 * (size_t)count, points);
    if (result != GLBK_OK) m->near_count = 0;
    return result == GLBK_OK ? glbk__ism_write_frame(ctx, m) : result;
}

static void glbk__ism_bind_points(glbk_context *ctx, const glbk_ism_maps *m)
{
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_vpls, &m->vpls);
    if (m->compute) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_points, &m->points);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_triangles, &m->triangle_table);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_positions, &m->positions);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
}

/* A group of ism_splat.comp and of ism_fill.comp for each tile, or for each of the squares that it is cut into. */
static glbk_result glbk__ism_dispatch(glbk_context *ctx, const glbk_ism_maps *m, glbk_program *program, uint32_t square)
{
    uint32_t groups = m->side / (m->desc.tile_size <= 64 ? m->desc.tile_size : square);
    return glbk_dispatch(ctx, program, groups, groups, 1);
}

/* The points of a phase, as many in a draw as may be. */
static glbk_result glbk__ism_draw_phase(glbk_context *ctx, glbk_ism_maps *m, uint32_t phase)
{
    const uint32_t all = m->each * m->desc.vpl_count, most = m->desc.points_per_pass;
    glbk_ism_frame f = glbk__ism_frame_of(m);
    glbk_result result = GLBK_OK;
    uint32_t first, count;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_points, &m->phase_points[phase]);
    for (first = 0; first < all && result == GLBK_OK; first += count) {
        count = all - first < most ? all - first : most;
        if (!m->quads) {
            ctx->gl.DrawArrays(GLBK_GL_POINTS, (int32_t)first, (int32_t)count);
            continue;
        }
        f.near_points[3] = first;               /* instances begin at 0 everywhere */
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame, &f);
        if (result == GLBK_OK) ctx->gl.DrawArraysInstanced(GLBK_GL_TRIANGLE_STRIP, 0, 4, (int32_t)count);
    }
    return result;
}

/* All points, cleared before. */
static glbk_result glbk__ism_splat(glbk_context *ctx, glbk_ism_maps *m)
{
    static const float empty[4] = { 0, 0, 0, 1e30f };
    glbk_pass pass;
    glbk_result result;
    uint32_t phase;
    if (m->compute) {
        glbk__ism_bind_points(ctx, m);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_ism_surfels_out, &m->surfels);
        return glbk__ism_dispatch(ctx, m, &m->splat, 64);
    }
    memset(&pass, 0, sizeof pass);
    pass.target = &m->surfel_target;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_begin(ctx, &pass, &m->splat);
    if (result != GLBK_OK) return result;
    glbk_clear(ctx, &m->surfel_target, 0, empty);
    glbk_clear_depth(ctx, 1);
    if (!m->triangles || !m->count) return GLBK_OK;
    glbk__ism_bind_points(ctx, m);
    for (phase = 0; phase < m->desc.lazy && result == GLBK_OK; phase++) result = glbk__ism_draw_phase(ctx, m, phase);
    return result;
}

static void glbk__ism_bind_surfels(glbk_context *ctx, const glbk_ism_maps *m)
{
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_vpls, &m->vpls);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_surfels, &m->surfels);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
}

/* A pass over a whole target that reads the maps and, in the slot "below", one texture. */
static glbk_result glbk__ism_pass(glbk_context *ctx, const glbk_ism_maps *m, const glbk_target *target,
                                  glbk_program *program, const glbk_texture *below)
{
    glbk_pass pass;
    glbk_result result;
    uint32_t i;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    result = glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    if (below) {
        glbk__ism_bind_surfels(ctx, m);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_below, below);
    }
    for (i = 0; target == &m->atlas_target && i < GLBK_ISM_LEVELS; i++)
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_pull1 + i, &m->pull[i]);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* From surfels to the atlas: holes, pull, push. */
static glbk_result glbk__ism_fill(glbk_context *ctx, glbk_ism_maps *m)
{
    uint32_t i, levels = glbk__ism_levels(m);
    glbk_result result;
    if (m->compute) {
        glbk__ism_bind_surfels(ctx, m);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_ism_atlas_out, &m->atlas);
        return glbk__ism_dispatch(ctx, m, &m->fill, 32);
    }
    result = glbk__ism_pass(ctx, m, &m->kept_target, &m->holes, &m->surfels);
    for (i = 0; i < levels && result == GLBK_OK; i++)
        result = glbk__ism_pass(ctx, m, &m->pull_target[i], &m->pull_program[i], i ? &m->pull[i - 1] : &m->kept);
    return result == GLBK_OK ? glbk__ism_pass(ctx, m, &m->atlas_target, &m->push, &m->kept) : result;
}

GLBK_DEF glbk_result glbk_ism_draw(glbk_context *ctx, glbk_ism_maps *m)
{
    uint64_t all;
    glbk_result result;
    if (!ctx || !m || !m->vpls.name) return GLBK_ERR_ARGUMENT;
    all = m->desc.lazy == 64 ? ~(uint64_t)0 : ((uint64_t)1 << m->desc.lazy) - 1;
    if (m->triangles && m->phases != all) return GLBK_ERR_ARGUMENT;
    result = glbk__ism_splat(ctx, m);
    return result == GLBK_OK ? glbk__ism_fill(ctx, m) : result;
}

GLBK_DEF glbk_result glbk_ism_read(glbk_context *ctx, const glbk_ism_maps *m, float *atlas)
{
    glbk__allocator memory;
    uint32_t *words, y, x;
    glbk_result result = GLBK_OK;
    if (!ctx || !m || !m->vpls.name || !atlas) return GLBK_ERR_ARGUMENT;
    memory = glbk__memory(ctx);
    words = (uint32_t *)glbk__alloc_array(&memory, m->side, 16);
    if (!words) return GLBK_ERR_ALLOC;
    for (y = 0; y < m->side && result == GLBK_OK; y++) {
        result = glbk_target_read(ctx, &m->atlas_target, 0, 0, y, m->side, 1, words);
        for (x = 0; x < m->side && result == GLBK_OK; x++)
            memcpy(atlas + (size_t)y * m->side + x, words + 4 * (size_t)x, 4);
    }
    glbk__free(&memory, words);
    return result;
}

/* The shading with its defaults, and what shaders read of it. */
static glbk_result glbk__ism_view_of(const glbk_ism_maps *m, const glbk_ism_shading *shading, glbk_ism_shading *s,
                                     glbk_ism_view *view)
{
    memset(s, 0, sizeof *s);
    s->bias = 0.02f;
    s->clamp = 1;
    if (shading) *s = *shading;
    if (!m || !m->vpls.name || s->near_mode > 6 || s->pattern > 8 || (s->pattern & (s->pattern - 1)) ||
        !(s->bias >= 0 && s->bias < 1) ||
        ((s->near_mode == 3 || s->near_mode == 4) && !(s->clamp > 0 && s->clamp < 3e38f)))
        return GLBK_ERR_ARGUMENT;
    if (!s->near_mode) s->near_mode = 6;
    if (!s->pairs_per_pass) s->pairs_per_pass = 1u << 28;
    memset(view, 0, sizeof *view);
    view->size[2] = s->pattern ? s->pattern : 1;
    view->size[3] = (s->no_maps ? 1u : 0u) | (s->irradiance ? 0u : 2u);
    view->values[0] = s->bias;
    view->values[1] = s->clamp;
    return GLBK_OK;
}

static void glbk__ism_bind_maps(glbk_context *ctx, const glbk_ism_maps *m)
{
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_vpls, &m->vpls);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_atlas, &m->atlas);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
}

GLBK_DEF glbk_result glbk_ism_bind(glbk_context *ctx, const glbk_ism_maps *m, const glbk_ism_shading *shading)
{
    glbk_ism_shading s;
    glbk_ism_view view;
    glbk_result result = ctx ? glbk__ism_view_of(m, shading, &s, &view) : GLBK_ERR_ARGUMENT;
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_ism_view, &m->view, &view);
    if (result == GLBK_OK) glbk__ism_bind_maps(ctx, m);
    return result;
}

GLBK_DEF glbk_result glbk_ism_renderer_create(glbk_context *ctx, uint32_t width, uint32_t height,
                                              glbk_ism_renderer *out)
{
    glbk_texture_desc d;
    glbk_target_desc t;
    glbk_result result = GLBK_OK;
    int i;
    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!width || !height) return GLBK_ERR_ARGUMENT;
    memset(&d, 0, sizeof d);
    memset(&t, 0, sizeof t);
    out->width = d.width = width;
    out->height = d.height = height;
    d.format = GLBK_FORMAT_COLOR;
    for (i = 0; i < 4 && result == GLBK_OK; i++) {
        result = glbk_texture_create(ctx, &d, &out->gbuffer[i]);
        t.color[i] = &out->gbuffer[i];
    }
    d.format = GLBK_FORMAT_DEPTH32F;
    t.depth = &out->depth;
    if (result == GLBK_OK) result = glbk_texture_create(ctx, &d, &out->depth);
    if (result == GLBK_OK) result = glbk_target_create(ctx, &t, &out->gbuffer_target);
    if (result == GLBK_OK)
        result = glbk__canvas(ctx, GLBK_FORMAT_COLOR, width, height, NULL, &out->light, &out->light_target);
    if (result == GLBK_OK)
        result = glbk__canvas(ctx, GLBK_FORMAT_COLOR, width, height, NULL, &out->result, &out->result_target);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_ism_view), NULL, &out->view);
    out->compute = ctx->compute;
    if (result == GLBK_OK)
        result = glbk_program_create(ctx, out->compute ? "ism_blur.comp" : "ism_blur.frag", NULL, &out->blur);
    if (result == GLBK_OK) result = glbk_program_create(ctx, "ism_resolve.frag", NULL, &out->resolve);
    if (result != GLBK_OK) glbk_ism_renderer_destroy(ctx, out);
    return result;
}

GLBK_DEF void glbk_ism_renderer_destroy(glbk_context *ctx, glbk_ism_renderer *r)
{
    int i;
    if (!r) return;
    glbk_target_destroy(ctx, &r->gbuffer_target);
    glbk_target_destroy(ctx, &r->light_target);
    glbk_target_destroy(ctx, &r->result_target);
    for (i = 0; i < 4; i++) glbk_texture_destroy(ctx, &r->gbuffer[i]);
    glbk_texture_destroy(ctx, &r->depth);
    glbk_texture_destroy(ctx, &r->light);
    glbk_texture_destroy(ctx, &r->result);
    glbk_buffer_destroy(ctx, &r->view);
    for (i = 0; i < 24; i++) glbk_program_destroy(ctx, &r->shade[i / 6][i % 6]);
    glbk_program_destroy(ctx, &r->blur);
    glbk_program_destroy(ctx, &r->resolve);
    memset(r, 0, sizeof *r);
}

GLBK_DEF glbk_result glbk_ism_gbuffer_upload(glbk_context *ctx, glbk_ism_renderer *r, const glbk_ism_receivers *from)
{
    const float *arrays[4];
    glbk__allocator memory;
    glbk_result result = GLBK_OK;
    size_t count, i, stride;
    float *texels;
    int k;
    if (!ctx || !r || !r->view.name || !from || !from->positions || !from->normals ||
        !glbk__stride_valid(from->stride, 12))
        return GLBK_ERR_ARGUMENT;
    arrays[0] = from->positions;
    arrays[1] = from->normals;
    arrays[2] = from->geometric ? from->geometric : from->normals;
    arrays[3] = from->albedos;
    stride = from->stride ? from->stride : 12;
    count = (size_t)r->width * r->height;
    memory = glbk__memory(ctx);
    texels = (float *)glbk__alloc_array(&memory, count, 16);
    if (!texels) return GLBK_ERR_ALLOC;
    for (k = 0; k < 4 && result == GLBK_OK; k++) {
        for (i = 0; i < count; i++) {
            texels[4 * i] = texels[4 * i + 1] = texels[4 * i + 2] = texels[4 * i + 3] = 1;
            if (arrays[k]) memcpy(texels + 4 * i, (const char *)arrays[k] + stride * i, 12);
        }
        result = glbk_texture_update(ctx, &r->gbuffer[k], 0, 0, 0, 0, r->width, r->height, 1, texels);
    }
    glbk__free(&memory, texels);
    return result;
}

/* Rows of pixels from one on by one program, which reads the G-buffer, the maps and, for the blur, the light: by
 * 16 x 16 of each class of pixels, `side` apart, in groups of the compute path. */
static glbk_result glbk__ism_shade_pass(glbk_context *ctx, const glbk_ism_renderer *r, const glbk_ism_maps *m,
                                        glbk_program *program, int blur, uint32_t side, uint32_t from, uint32_t rows)
{
    glbk_pass pass;
    glbk_result result = GLBK_OK;
    uint32_t i, square = 16 * side;
    memset(&pass, 0, sizeof pass);
    pass.target = blur ? &r->result_target : &r->light_target;
    pass.viewport[1] = (int32_t)from;
    pass.viewport[2] = (int32_t)r->width;
    pass.viewport[3] = (int32_t)rows;
    if (!r->compute) result = glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    for (i = 0; i < 4; i++) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_place + i, &r->gbuffer[i]);
    if (blur) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_light, &r->light);
    else glbk__ism_bind_maps(ctx, m);
    if (!r->compute) {
        glbk_draw_screen(ctx);
        return GLBK_OK;
    }
    glbk_bind_image(ctx, GLBK_SLOT_glbk_ism_light_out, blur ? &r->result : &r->light);
    return glbk_dispatch(ctx, program, (r->width + square - 1) / square, (rows + square - 1) / square, side * side);
}

/* All pixels in the light of all VPLs, so many rows at a time as have `pairs` of them; whole squares of the compute
   path. */
static glbk_result glbk__ism_shade_all(glbk_context *ctx, const glbk_ism_renderer *r, const glbk_ism_maps *m,
                                       glbk_program *program, glbk_ism_view *view, uint32_t pairs)
{
    const uint32_t side = view->size[2], square = 16 * side;
    const uint64_t row = (uint64_t)r->width * (m->count / (side * side) + 1);
    uint64_t step = pairs / row / square * square;
    glbk_result result = GLBK_OK;
    uint32_t from = 0, rows;
    if (step < square) step = square;
    for (; from < r->height && result == GLBK_OK; from += rows) {
        rows = r->height - from < step ? r->height - from : (uint32_t)step;
        view->values[2] = (float)from;
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_ism_view, &r->view, view);
        if (result == GLBK_OK) result = glbk__ism_shade_pass(ctx, r, m, program, 0, side, from, rows);
    }
    return result;
}

GLBK_DEF glbk_result glbk_ism_shade(glbk_context *ctx, glbk_ism_renderer *r, const glbk_ism_maps *m,
                                    const glbk_ism_shading *shading)
{
    char defines[] = "ISM_PROJECTION=1 ISM_NEAR=1";
    glbk_program *program;
    glbk_ism_shading s;
    glbk_ism_view view;
    glbk_result result = glbk__ism_view_of(m, shading, &s, &view);
    if (result != GLBK_OK || !ctx || !r || !r->view.name) return GLBK_ERR_ARGUMENT;
    defines[15] = (char)('0' + (int)m->desc.projection);
    defines[26] = (char)('0' + (int)s.near_mode);
    program = &r->shade[m->desc.projection - 1][s.near_mode - 1];
    if (!program->name)
        result = glbk_program_create(ctx, r->compute ? "ism_shade.comp" : "ism_shade.frag", defines, program);
    view.size[0] = r->width;
    view.size[1] = r->height;
    if (result == GLBK_OK) result = glbk__ism_shade_all(ctx, r, m, program, &view, s.pairs_per_pass);
    return result == GLBK_OK ? glbk__ism_shade_pass(ctx, r, m, &r->blur, 1, 1, 0, r->height) : result;
}

GLBK_DEF glbk_result glbk_ism_resolve(glbk_context *ctx, glbk_ism_renderer *r, const glbk_pass *pass)
{
    glbk_ism_view view;
    glbk_result result;
    if (!ctx || !r || !r->resolve.name || !pass) return GLBK_ERR_ARGUMENT;
    memset(&view, 0, sizeof view);
    result = glbk__corner(ctx, pass, r->width, r->height, view.size);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_ism_view, &r->view, &view);
    if (result == GLBK_OK) result = glbk_begin(ctx, pass, &r->resolve);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_light, &r->result);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_ism_read_light(glbk_context *ctx, const glbk_ism_renderer *r, float *rgb)
{
    glbk__allocator memory;
    float *texels;
    size_t i, count;
    glbk_result result;
    if (!ctx || !r || !r->view.name || !rgb) return GLBK_ERR_ARGUMENT;
    count = (size_t)r->width * r->height;
    memory = glbk__memory(ctx);
    texels = (float *)glbk__alloc_array(&memory, count, 16);
    if (!texels) return GLBK_ERR_ALLOC;
    result = glbk_target_read(ctx, &r->result_target, 0, 0, 0, r->width, r->height, texels);
    for (i = 0; i < count && result == GLBK_OK; i++) memcpy(rgb + 3 * i, texels + 4 * i, 12);
    glbk__free(&memory, texels);
    return result;
}

/* ---- end of ism ---- */

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
