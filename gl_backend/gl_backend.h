/* gl_backend.h - v0.9.0 - what all gl_*.h share: a layer on OpenGL 3.3, ES 3.0, WebGL 2 - MIT-0 OR Unlicense

   What it does

   gl_csm.h, gl_shadowfield.h, gl_envshadow.h, gl_rsm.h and gl_ism.h bring the techniques onto the GPU:
   uploads as plain textures, GLSL functions to paste into your own shaders with a call that binds what they
   need, and complete passes. This is the small layer underneath, which they include and which you may use by
   itself: GL functions without a loader, programs from the embedded GLSL, textures, targets, passes, state.

   What it does not do

   - No window, no context: make one (GLFW, EGL, SDL, Emscripten, ...) and make it current. OpenGL 3.3 core,
     ES 3.0 or more. The core path has no geometry shaders, texture buffers or compute; with 4.3 a compute
     path is used as well.
   - Not inside an active transform feedback, query of the same kind or conditional rendering of yours.
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
   (07 to 10 of the other techniques). It wants csm.h, gl_backend/gl_csm.h and GLFW, and a display: without
   one xvfb-run -a before it.

   Conventions

   Matrices column-major float[16]; GL names are uint32_t; rows of textures from the bottom up, as GL has
   them. Clip depth is GL's -1..1: passes set it back where a context has clip control.

     file       a piece of GLSL in a header: a library file (functions) or a program's main
     part       all files of one header, and the slots of what they declare
     set        defines that a program is compiled with: "FILTER=1 COUNT=4"
     slot       number of a texture unit, uniform block, storage buffer or image as the lists of bindings give
                it; the context adds desc.first_unit to those of textures and desc.first_block to those of
                uniform blocks
     table      an array of texels, addressed by one number: a 2D array texture 1024 wide and 1024 high
     target     a framebuffer object with the sizes and formats of what is attached
     pass       what GL must be set to before something is drawn

   How it works

   All GL functions come from your get_proc_fn and are kept in the context object: several contexts live side
   by side, no GL header and no link against GL is needed. What exists is decided by version and extension
   strings, not by whether get_proc_fn returns something. GLSL is kept without its comments, a text for each
   file under src/gl and src/gl_*; a program is version line, defines, lib/prelude.glsl, the library files
   that it names, and its own. One text serves 330 core and 300 es. Names, units and block layouts come from
   one list for each header that C, GLSL and the tests share.

   Floats on ES 3.0 and WebGL 2 are renderable with EXT_color_buffer_float only. Without it a target of format
   GLBK_FORMAT_COLOR holds the bits of floats in integers, and lib/prelude.glsl hides the difference
   (glbk_color).

   Configuration

     GL_BACKEND_IMPLEMENTATION   in one source file: compiles the code
     GLBK_STATIC                 everywhere it is included: a private copy, all functions static
     GLBK_DEF                    everywhere: your own linkage instead

   Memory, errors, threads, determinism

   Memory comes from the allocator in the desc, only while a program is compiled and by calls that say so.
   Every function that can fail returns a glbk_result; where it is not GLBK_OK its outputs are zeroed, GL
   objects made on the way are deleted, and desc.system.log gets the driver's words, the name of what is
   missing, or the field that is wrong with its value and its range. Calls that create, compile or read refuse
   to start while a GL error is pending (GLBK_ERR_PENDING), so none of yours gets lost or blamed on us. Those
   of a frame (_update, _upload, _place, _object, _render, _shade, ...) do not ask for GL's error flag, which
   would wait for the driver: they return what they see by themselves. Call glbk_check once a frame, or set
   desc.check while you look for an error: then all of them ask, before and after. Creating, updating, reading
   and destroying leave every GL state as they found it; passes change what docs/gl-state.md lists, and
   glbk_state_save and glbk_state_restore bring it back. Objects are destroyed explicitly; destroying accepts
   NULL, zeroed and half-built objects and, after glbk_abandon or GLBK_ERR_LOST, calls no GL. A context and
   its objects belong to the thread where the GL context is current. No globals.

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

/* ==== src/gl/gl_functions.h ==== */

/* ---- results ---- */

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

GLBK_DEF const char *glbk_result_text(glbk_result result);
/* Returns what a result means as a constant string, "unknown result" for a value beyond the list. */

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
    GLBK_GL_TEXTURE_2D = 0x0DE1, GLBK_GL_TEXTURE_2D_ARRAY = 0x8C1A, GLBK_GL_TEXTURE0 = 0x84C0,
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

/* ==== src/gl/api.h ==== */

/* ---- the context ---- */

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

typedef struct glbk_desc {
    glbk_system    system;
    glbk_get_proc_fn get_proc_fn;   /* required */
    void          *user;            /* handed to get_proc_fn */
    int            core_only;       /* not 0: what 3.3 and ES 3.0 share, even where the context has more */
    uint32_t       first_unit;      /* texture units first_unit .. + 15 are ours while we draw, and those
                                       further on, below + GLBK_MAX_UNITS, that a glbk_offset names */
    uint32_t       first_block;     /* likewise bindings of uniform blocks, first_block .. + 7, below +
                                       GLBK_MAX_BLOCKS; storage buffers and images, of compute alone, are
                                       always at 0 .. 7, as GLSL says their numbers */
    int            check;           /* not 0: calls of a frame ask for GL's error flag, too, and glbk_check
                                       and the glbk_..._resolve for the framebuffer; slow, to look for
                                       errors */
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
    uint32_t       max_side;        /* texels a side of a 2D texture */
    uint32_t       max_layers;      /* of an array texture */
    uint32_t       max_targets;     /* colour attachments that can be drawn to at once */
    float          max_point_side;  /* pixels */
    /* The rest is private. */
    uint32_t       vertex_array;    /* empty, for passes that need no attributes */
    uint32_t       shown;           /* buffer of the block glbk_shown of gl_gbuffer.h */
    int            lost;            /* calls no GL any more */
    glbk_system    system;
    uint32_t       first_unit, first_block;
    uint32_t       unit_count, block_count;     /* that there are from those on, at most GLBK_MAX_UNITS,
                                                   _BLOCKS */
    int            each_target;     /* colour mask and blending are switched for each target */
    int            each_blend;      /* ... and have functions of their own */
    int            offset_clamp;
    int            check;           /* desc.check */
    uint32_t       inner;           /* the framebuffer that glbk_begin bound last, if it is a technique's */
    size_t         max_storage;     /* bytes of a storage buffer */
} glbk_context;

#define GLBK_UNITS 16u              /* slots of textures, of uniform blocks, of storage buffers */
#define GLBK_BLOCKS 8u
#define GLBK_IMAGES 8u              /* slots of images, for compute */
#define GLBK_MAX_UNITS 32u          /* with offsets, where the context has as many; a shader stage has 16 */
#define GLBK_MAX_BLOCKS 16u

GLBK_DEF glbk_result glbk_init(glbk_context *ctx, const glbk_desc *desc);
/* Loads GL's functions from the context that is current, decides what it can do, and makes one empty vertex
   array and one small buffer.
   ctx      is yours, may be moved in memory afterwards, and is zeroed on errors
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC; GLBK_ERR_CONTEXT; GLBK_ERR_OLD_CONTEXT; GLBK_ERR_FUNCTION, its
            name in the log; GLBK_ERR_LIMIT where first_unit or first_block reach beyond what the context has;
            GLBK_ERR_PENDING, GLBK_ERR_LOST, GLBK_ERR_GL, GLBK_ERR_GL_MEMORY */

GLBK_DEF void glbk_free(glbk_context *ctx);
/* Deletes what glbk_init made and zeroes ctx, which may be NULL. Free textures, buffers, targets and programs
   before: afterwards their _free functions call no GL. */

GLBK_DEF void glbk_abandon(glbk_context *ctx);
/* Says that the GL context is gone or not current: from now on the _free functions touch memory only, and all
   other calls return GLBK_ERR_LOST or do nothing. ctx may be NULL. */

GLBK_DEF glbk_result glbk_check(glbk_context *ctx);
/* Takes GL's error flag and returns it as a result, with its number in the log: GLBK_OK, GLBK_ERR_GL,
   GLBK_ERR_GL_MEMORY, or GLBK_ERR_LOST, which no call of a frame notices by itself. Passes and updates do not
   ask for the flag (unless desc.check is set), so call this once a frame; it makes drivers with threads of
   their own wait for what was asked of them. With desc.check it returns GLBK_ERR_ORDER while a technique's
   framebuffer is bound: what you drew since that technique's passes went into it. After such passes bind your
   own framebuffer, or put glbk_state_save and glbk_state_restore round them. */

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
/* Makes a texture with its sampling, and fills level 0 where desc.data is given; of a float format its
   mipmaps need ctx->float_targets.
   out      is zeroed on errors; free it with glbk_texture_free
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC; GLBK_ERR_LIMIT, for a size above ctx->max_side or max_layers;
            GLBK_ERR_FLOAT_TARGET, for mipmaps; GLBK_ERR_GL_MEMORY, GLBK_ERR_PENDING, GLBK_ERR_GL,
            GLBK_ERR_LOST. These last four hold for every function below that creates, compiles or reads; of
            the others GLBK_ERR_LOST alone does, and all four with desc.check */

GLBK_DEF glbk_result glbk_texture_update(glbk_context *ctx, const glbk_texture *texture, uint32_t level,
                                         uint32_t x, uint32_t y, uint32_t layer, uint32_t width,
                                         uint32_t height, uint32_t layers, const void *data);
/* Overwrites a box of texels of one level; other levels stay as they are, mipmaps too.
   x .. height      texels of that level, from its lower left corner on; the box must lie within it
   layer, layers    the first layer and how many; 0 and 1 for a 2D texture
   data             texels in the texture's format, rows and layers without padding; read during the call
   Errors           GLBK_ERR_ARGUMENT; GLBK_ERR_LOST */

GLBK_DEF void glbk_texture_free(glbk_context *ctx, glbk_texture *texture);
/* Deletes a texture and zeroes it. NULL and zeroed ones are allowed, here and in the other _free
   functions. */

/* ---- buffers: uniform blocks, vertices, and storage where ctx->compute ---- */

typedef struct glbk_buffer {        /* read only; zeroed = none */
    uint32_t name;
    size_t   bytes;
} glbk_buffer;

GLBK_DEF glbk_result glbk_buffer_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out);
/* Makes a buffer for any purpose, one after another too, but for indices.
   bytes    1 or more
   data     so many bytes, or NULL: the buffer's bytes are undefined then
   out      is zeroed on errors; free it with glbk_buffer_free
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_LIMIT, for more bytes than PTRDIFF_MAX */

GLBK_DEF glbk_result glbk_indices_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out);
/* Makes a buffer for indices alone, as glbk_buffer_create does: WebGL allows indices in no buffer that was
   bound to anything else first. */

GLBK_DEF glbk_result glbk_buffer_update(glbk_context *ctx, const glbk_buffer *buffer, size_t offset,
                                        size_t bytes, const void *data);
/* Overwrites `bytes` bytes from byte `offset` on; the run must lie within the buffer. A whole buffer in one
   call costs least: it gets new storage, so that nothing waits for draws from the old.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_LOST */

GLBK_DEF glbk_result glbk_buffer_read(glbk_context *ctx, const glbk_buffer *buffer, size_t offset,
                                      size_t bytes, void *out);
/* Copies `bytes` bytes from byte `offset` on to out; the run must lie within the buffer. It waits until the
   GPU has done all that was asked of it before, so it is for tests and tools, not for frames.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_FEATURE on ES and WebGL, which cannot read buffers */

GLBK_DEF void glbk_buffer_free(glbk_context *ctx, glbk_buffer *buffer);

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
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, where there is no attachment, or a layer or level that a texture
            has not; GLBK_ERR_MISMATCH, where sizes differ or a depth texture stands for colours;
            GLBK_ERR_FLOAT_TARGET, for floats without ctx->float_targets; GLBK_ERR_TARGET, where the driver
            cannot draw to this combination */

GLBK_DEF glbk_result glbk_target_read(glbk_context *ctx, const glbk_target *target, uint32_t attachment,
                                      uint32_t x, uint32_t y, uint32_t width, uint32_t height, void *rgba);
/* Copies width x height pixels of a colour attachment from the GPU, from pixel (x, y) on, rows from the
   bottom up. It waits until the GPU has done all that was asked of it before.
   attachment   0 .. target->count - 1
   rgba         receives 16 bytes a pixel: four floats, or four uint32_t where the format has integers. Of a
                GLBK_FORMAT_COLOR target these are the floats in either case
   Errors       GLBK_ERR_ARGUMENT, also where the pixels do not lie within the target */

GLBK_DEF void glbk_target_free(glbk_context *ctx, glbk_target *target);

/* ==== src/gl/api_shaders.h ==== */

/* ---- GLSL and programs ---- */

typedef struct glbk_file {          /* one file of GLSL, as a header holds it */
    const char        *name;        /* "lib/table.glsl", "prog/copy.frag" */
    const char *const *texts;       /* without comments, and blanks that divide nothing; fit for
                                       glShaderSource */
    uint32_t           text_count;
    const char        *uses;        /* library files that go before it, by bare names: "table csm_bindings" */
    const char        *with;        /* of a .frag: its vertex shader; else "" */
    const char        *sets;        /* the define sets that are tested, separated by " | " */
    const char        *block;       /* the uniform block that it declares, and nothing else; or "" */
} glbk_file;

typedef struct glbk_slot { const char *name; uint32_t slot; } glbk_slot;

/* The GLSL of one header. Each header has a function that returns its own: glbk_base_part for this one,
   glbk_csm_part for gl_csm.h and so on. Nothing is registered anywhere: a program is given the parts whose
   files it uses, and a linker leaves out the GLSL of all others. */
typedef struct glbk_part {
    const char      *name;          /* "csm" */
    const glbk_file *files;
    uint32_t         file_count;
    const glbk_slot *textures, *blocks;     /* each ends with an entry that has no name */
} glbk_part;

#define GLBK_MAX_PARTS 6u           /* that one program can use beside the base, which every program can */

GLBK_DEF const glbk_part *glbk_base_part(void);
/* Returns the GLSL of this header, a constant. */

GLBK_DEF const glbk_file *glbk_find_file(const glbk_part *part, const char *name);
/* Returns a file of the part or else of the base by its name ("lib/table.glsl"), NULL if neither has it. It
   needs no context.
   part   NULL = the base's files alone */

typedef struct glbk_offset {        /* where the slots of a part begin in a program that uses several parts */
    uint32_t unit, block;           /* added to the slots of its textures and of its uniform blocks */
} glbk_offset;

typedef struct glbk_source {        /* a program of your own, with library files */
    const char *vertex;             /* main of the vertex shader as text; NULL = a triangle over the whole
                                       screen */
    const char *fragment;           /* main of the fragment shader as text, or NULL with compute */
    const char *compute;
    const char *uses;               /* library files by their bare names, in order, without what they use
                                       themselves; uniform blocks of the library that your text names are
                                       found */
    const char *defines;            /* "FILTER=1 FAST", or NULL; the vertex shader sees them too */
    const char *outputs;            /* names for transform feedback, separated by blanks, interleaved; or
                                       NULL */
    const glbk_part *parts[GLBK_MAX_PARTS];     /* whose files it uses: glbk_csm_part(), ...; NULLs are left
                                                   out */
    glbk_offset offsets[GLBK_MAX_PARTS];        /* of the slots of each of these parts. What a technique's
                                                   glbk_..._bind binds for this program needs the same
                                                   offset */
} glbk_source;

typedef struct glbk_program {       /* read only; zeroed = none */
    uint32_t name;
    int      slots_set;             /* private */
    const glbk_part *parts[GLBK_MAX_PARTS];     /* private */
    glbk_offset offsets[GLBK_MAX_PARTS];        /* private */
} glbk_program;

GLBK_DEF glbk_result glbk_program_compile(glbk_context *ctx, const glbk_source *source, glbk_program *out);
/* Compiles and links a program from your text, which has no #version line: the text that the driver gets
   begins with that line and lib/prelude.glsl. Compiling takes milliseconds to seconds: do it before the first
   frame.
   source   is read during the call only
   out      is zeroed on errors; free it with glbk_program_free
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, where not one of fragment and compute is given, or outputs are
            too long; GLBK_ERR_NAME, where a library file is unknown or defines do not parse;
            GLBK_ERR_COMPILE, GLBK_ERR_LINK, the driver's words in the log, where line 2007 is line 7 of file
            2, listed there too; GLBK_ERR_ALLOC; GLBK_ERR_FEATURE, for compute without ctx->compute;
            GLBK_ERR_MISMATCH, where two samplers or two uniform blocks that the program declares have one
            texture unit or one binding, both in the log: give one part an offset; GLBK_ERR_LIMIT, where an
            offset leads beyond GLBK_MAX_UNITS, GLBK_MAX_BLOCKS or what the context has from first_unit on */

typedef enum glbk_dialect {
    GLBK_GLSL_DEFAULT,              /* = GLBK_GLSL_330 */
    GLBK_GLSL_330,
    GLBK_GLSL_300_ES,
    GLBK_GLSL_430,
    GLBK_GLSL_COUNT
} glbk_dialect;

typedef struct glbk_shader {        /* one stage of a program */
    const char *uses, *defines;     /* as in glbk_source, or NULL */
    const char *name;               /* the file with its main ("prog/copy.frag", which brings its own uses),
                                       or NULL */
    const char *text;               /* your text, behind that file if both are given; or NULL */
    const glbk_part *parts[GLBK_MAX_PARTS];     /* as in glbk_source */
} glbk_shader;

GLBK_DEF size_t glbk_write_glsl(glbk_dialect dialect, int float_bits, const glbk_shader *shader, char *out,
                                size_t bytes);
/* Writes the text that glbk_program_compile gives to the driver for one stage, for a renderer with shaders of
   its own. It needs no context. Returns the bytes that the text needs with its 0, or 0 where a name is
   unknown or defines do not parse.
   float_bits   not 0: GLBK_FORMAT_COLOR targets hold integers, as they do without ctx->float_targets
   out          receives the text, cut to `bytes` bytes and ended by 0; it may be NULL with bytes 0 */

GLBK_DEF void glbk_program_free(glbk_context *ctx, glbk_program *program);
/* Deletes a program and zeroes it. */

GLBK_DEF void glbk_program_use(glbk_context *ctx, glbk_program *program);
/* Makes a program the one in use; at the first time its textures and blocks get their slots. glbk_begin and
   glbk_dispatch do this by themselves. Where program is NULL or the context is lost nothing happens. */

enum { GLBK_SLOT_glbk_user0 = 12, GLBK_SLOT_glbk_user1, GLBK_SLOT_glbk_user2, GLBK_SLOT_glbk_user3 };

GLBK_DEF glbk_result glbk_set_slots(glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                    uint32_t gl_program);
/* Gives the textures and blocks of a program that you linked yourself their slots, as glbk_program_use does
   for the library's: those of the part's and the base's lists that it declares, and samplers of yours that
   are called glbk_user0 to glbk_user3, which have the slots above. Call it once after linking; the program
   need not be in use. The slots 12 to 15 are free beside the functions for your own shaders. They are not
   beside lib/ism_gbuffer.glsl and the programs of rsm and ism themselves: glbk_rsm_states, _coarse, _history
   and _before have 12 to 15, ism's G-buffer and light 11 to 15.
   part         NULL = the base alone
   offset       moves the part's slots; NULL = not at all. The base's stay where they are
   gl_program   GL's name of a linked program
   Errors       GLBK_ERR_ARGUMENT; GLBK_ERR_LIMIT, GLBK_ERR_MISMATCH, as glbk_program_compile says;
                GLBK_ERR_LOST. Nothing is set then */

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
    const glbk_target *target;      /* NULL = the framebuffer that is bound; then the viewport must be given,
                                       and FRAMEBUFFER_SRGB is as you have set it: no pass encodes colours by
                                       itself */
    int32_t            viewport[4]; /* x, y, width, height; all zero = the whole target */
    glbk_depth         depth;
    glbk_blend         blend;
    glbk_cull          cull;
    int                no_color;    /* not 0: writes depth only */
    float              offset[2];   /* of depth: factor and units of glPolygonOffset; both 0 = off */
} glbk_pass;                        /* all zero but the target: overwrite everything */

GLBK_DEF glbk_result glbk_begin(glbk_context *ctx, const glbk_pass *pass, glbk_program *program);
/* Begins a pass: sets every state that a draw depends on, so that nothing inherited shows, and binds the
   target, the program and the empty vertex array. Bind textures and blocks after it. docs/gl-state.md lists
   what is touched.
   program  NULL where you use your own
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_DESC, GLBK_ERR_LOST; GL's error flag is not asked */

GLBK_DEF void glbk_clear(glbk_context *ctx, const glbk_target *target, uint32_t attachment,
                         const float rgba[4]);
/* Fills a colour attachment of the target that glbk_begin has bound, whatever the viewport. Integer formats
   get the numbers, rounded, within 0 and 2^32 - 1; GLBK_FORMAT_COLOR gets the floats. Where an argument is
   NULL or attachment is not below target->count nothing happens. */

GLBK_DEF void glbk_clear_depth(glbk_context *ctx, float depth);
/* Fills the depth of the target that glbk_begin has bound, in a pass whose depth mode writes. depth is 0
   (near) .. 1 (far). */

GLBK_DEF void glbk_bind_texture(glbk_context *ctx, uint32_t slot, const glbk_texture *texture);
/* Binds a texture to a slot for the draws and dispatches that follow, without a sampler object.
   slot      GLBK_SLOT_name of the lists, plus its part's offset, counted from ctx->first_unit on. One beyond
             GLBK_MAX_UNITS or the context's last unit does nothing: bind textures of your own there yourself
   texture   NULL or not created: the unit gets no texture, for a sampler that is declared and not read. What
             others left there may be of another kind than the sampler, and WebGL then refuses to draw */

GLBK_DEF void glbk_bind_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer);
/* Binds a whole buffer as the uniform block of a slot, GLBK_SLOT_name plus its part's offset, counted from
   ctx->first_block on. A slot beyond what the context has does nothing, nor does NULL. */

GLBK_DEF void glbk_bind_storage(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer);
/* Binds a whole buffer as the storage buffer of a slot, 0 .. 7, for compute shaders. Without ctx->compute
   nothing happens. */

GLBK_DEF void glbk_bind_image(glbk_context *ctx, uint32_t slot, const glbk_texture *texture);
/* Binds level 0 of a texture, all layers, to an image slot, 0 .. 7, which compute shaders read and write.
   Without ctx->compute nothing happens. The shader's layout must name the texture's format: rgba32f for
   GLBK_FORMAT_COLOR. GL has no images of sRGB and of depth. */

GLBK_DEF void glbk_draw_screen(glbk_context *ctx);
/* Draws one triangle over the whole viewport, after glbk_begin, from no attributes. */

GLBK_DEF glbk_result glbk_dispatch(glbk_context *ctx, glbk_program *program, uint32_t x, uint32_t y,
                                   uint32_t z);
/* Runs x * y * z groups of a compute program and makes what it wrote visible to everything after it.
   x, y, z  each 0 .. 65535, which every context allows
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_FEATURE without ctx->compute; GLBK_ERR_LOST */

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
   both round a pass or a whole frame of them where the rest of your renderer relies on its state. It asks GL
   some hundred times, which drivers with threads of their own wait for. */

GLBK_DEF void glbk_state_restore(glbk_context *ctx, const glbk_state *state);
/* Sets again what glbk_state_save has kept. What was bound must not be deleted in between; a program that you
   had deleted while it was in use is gone (0) afterwards, as GL says. */

/* ---- bindings ----

   Each part (this header, and each technique's) has four lists, empty where it needs none:

     GLBK_part_TEXTURES(X)   X(GLSL type, name, slot)
     GLBK_part_BLOCKS(X)     X(name, slot, MEMBERS), each with a list MEMBERS(X): X(GLSL type, name, count)
     GLBK_part_STORAGE(X)    X(qualifiers, GLSL type, name, slot), an array without size, for compute
     GLBK_part_IMAGES(X)     X(qualifiers, format, GLSL type, name, slot), for compute

   A list may consist of other lists, each named with (X) behind it. Slots of textures count from 0 to
   GLBK_UNITS - 1, those of blocks, storage and images to 7, anew in each part. A program that uses several
   parts gives each a glbk_offset, so that they do not meet; base being one too, whose slots stay. From the
   lists come GLBK_SLOT_name, the C struct of each block, and the library file "part_bindings". Members are
   read as block.member. Their layout is std140 and that of C at the same time: members are mat4, vec4,
   ivec4, uvec4, arrays of these, and float and uint, four of which fill the place of a vec4; tools/check-
   glsl compares both layouts. */

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
#define GLBK__MEMBER_float(name, count) float name;     /* count is 1: std140 would spread an array */
#define GLBK__MEMBER_uint(name, count) uint32_t name;
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

/* ==== src/gl/inside.h ==== */

/* ---- for the techniques' headers: not for you, may change without notice ----

   Their implementations may stand in other files than this header's, hence no static functions: GLBK__DEF is
   GLBK_DEF for them. */

#define GLBK__TEXTURE_ENTRY(type, name, slot) { #name, slot },
#define GLBK__BLOCK_ENTRY(name, slot, members) { #name "_block", slot },
#define GLBK__PART_CODE(part, PART)                                                                \
    static const glbk_slot glbk__##part##_units[] = {                                              \
        GLBK_##PART##_TEXTURES(GLBK__TEXTURE_ENTRY) { NULL, 0 }                                    \
    };                                                                                             \
    static const glbk_slot glbk__##part##_bindings[] = {                                           \
        GLBK_##PART##_BLOCKS(GLBK__BLOCK_ENTRY) { NULL, 0 }                                        \
    };                                                                                             \
    GLBK__PART_FUNCTION(part)
#define GLBK__PART_FUNCTION(part)                                                                  \
    static const glbk_part glbk__##part##_part = {                                                 \
        #part, glbk__##part##_files, sizeof glbk__##part##_files / sizeof glbk__##part##_files[0], \
        glbk__##part##_units, glbk__##part##_bindings                                              \
    };                                                                                             \
    GLBK_DEF const glbk_part *glbk_##part##_part(void) { return &glbk__##part##_part; }

/* Every call that can fail and calls GL begins with glbk__enter, which returns GLBK_ERR_ARGUMENT for no
   context, GLBK_ERR_LOST, or GLBK_ERR_PENDING, and ends with glbk__leave, which returns the errors that GL
   has kept since. A call of a frame ends with glbk__leave_frame, which asks GL with desc.check alone.
   glbk__leave_created ends a creating call whose last steps were those of a frame: where result is GLBK_OK it
   asks GL. */
GLBK__DEF glbk_result glbk__enter(glbk_context *ctx);
GLBK__DEF glbk_result glbk__leave(glbk_context *ctx);
GLBK__DEF glbk_result glbk__leave_frame(glbk_context *ctx);
GLBK__DEF glbk_result glbk__leave_created(glbk_context *ctx, glbk_result result);

/* These log why a call fails and return the result: "FUNCTION: FIELD TEXT"; "FUNCTION: FIELD is VALUE; it
   must be WANTED"; "FUNCTION: FIELD is VALUE; it must be LOW..HIGH". function is __func__ of the public
   function. */
GLBK__DEF glbk_result glbk__refuse(const glbk_context *ctx, glbk_result result, const char *function,
                                   const char *field, const char *text);
GLBK__DEF glbk_result glbk__refuse_value(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *field, double value, const char *wanted);
GLBK__DEF glbk_result glbk__refuse_range(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *field, double value, double low, double high);
/* Logs "FUNCTION: MESH: index 2 of triangle 17 is 90, but the mesh has 80 vertices" and returns the result;
   position counts indices from 0. */
GLBK__DEF glbk_result glbk__refuse_index(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *mesh, size_t position, size_t index,
                                         size_t vertex_count);

/* Returns *offset, or zeros for NULL. */
GLBK__DEF glbk_offset glbk__offset(const glbk_offset *offset);

/* Gives a uniform block all its values for the draws that follow, and binds it to its slot. */
GLBK__DEF glbk_result glbk__put_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer,
                                      const void *values);

/* glbk__canvas makes a texture and a target of it, with `depth` if that is not NULL. glbk__target_create
   makes a target as glbk_target_create does. Both are a technique's own: nobody else is to draw to them,
   which glbk_check looks for. glbk__attach attaches a texture to the framebuffer that is bound; NULL does
   nothing. */
GLBK__DEF glbk_result glbk__canvas(glbk_context *ctx, glbk_format format, uint32_t width, uint32_t height,
                                   const glbk_texture *depth, glbk_texture *texture, glbk_target *target);
GLBK__DEF glbk_result glbk__target_create(glbk_context *ctx, const glbk_target_desc *desc, glbk_target *out);
GLBK__DEF void glbk__attach(const glbk_context *ctx, uint32_t attachment, const glbk_texture *t,
                            uint32_t level, uint32_t layer);

/* With desc.check, returns GLBK_ERR_ORDER and logs it while a technique's framebuffer is bound. */
GLBK__DEF glbk_result glbk__check_bound(const glbk_context *ctx, const char *function);

/* Enables or disables what glEnable knows by that name. */
GLBK__DEF void glbk__set_cap(const glbk_context *ctx, uint32_t name, int on);

/* Compiles and links a program of the library.
   part     has it; NULL = the base
   other    a second part whose library files it uses, or NULL
   name     is that of its last stage: "copy.frag", "csm_query.comp"
   defines  one of its sets, or NULL = none
   Errors   those of glbk_program_compile; GLBK_ERR_NAME where the part has no such file */
GLBK__DEF glbk_result glbk__program_create(glbk_context *ctx, const glbk_part *part, const char *name,
                                           const char *defines, glbk_program *out);
GLBK__DEF glbk_result glbk__program_of_parts(glbk_context *ctx, const glbk_part *part, const glbk_part *other,
                                             const char *name, const char *defines, glbk_program *out);

/* A table is an array texture that lib/table.glsl reads by one number: texel i stands at (i & 1023, i >> 10 &
   1023, i >> 20). texels: count of them, 1 .. ctx->max_layers * 2^20, in any format but the depth formats, or
   NULL = undefined. On the GPU it takes count rounded up to rows of 1024, above 2^20 texels to layers of
   2^20; beyond ctx->max_layers of them it is GLBK_ERR_LIMIT. Updating sets count texels from number first on,
   as a call of a frame. */
GLBK__DEF glbk_result glbk__table_create(glbk_context *ctx, glbk_format format, const void *texels,
                                         size_t count, glbk_texture *out);
GLBK__DEF glbk_result glbk__table_update(glbk_context *ctx, const glbk_texture *table, size_t first,
                                         size_t count, const void *texels);

/* Text that is counted in `used` and written as far as there is room: glbk__append adds so many characters,
   glbk__append_text a string, glbk__append_file a file of GLSL. */
typedef struct glbk__sink {
    char  *out;
    size_t bytes, used;
} glbk__sink;
GLBK__DEF void glbk__append(glbk__sink *sink, const char *text, size_t length);
GLBK__DEF void glbk__append_text(glbk__sink *sink, const char *text);
GLBK__DEF void glbk__append_file(glbk__sink *sink, const glbk_file *file);

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

/* Returns 1 if the functions of a public allocator are both there or both NULL. */
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

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *glbk__alloc(const glbk__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void glbk__free(const glbk__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/gl_memory.h ==== */

/* unit gl_memory, needs mem: the allocator of a glbk_context (gl_backend.h) */

static inline glbk__allocator glbk__memory(const glbk_context *ctx)
{
    const glbk_allocator *a = &ctx->system.allocator;
    return glbk__allocator_make(a->alloc_fn, a->free_fn, a->user);
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
static inline GLBK__COLD void glbk__message_begin(glbk__message *m, const glbk__logger *logger, const char *field)
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

/* Logs "FUNCTION: mesh: index 2 of triangle 17 is 90, but the mesh has 80 vertices". position counts the
   indices from 0. */
static inline GLBK__COLD void glbk__log_index(const glbk__logger *logger, const char *mesh, uint64_t position,
                                      uint64_t index, uint64_t vertex_count)
{
    glbk__message m;
    if (!logger->log) return;
    glbk__message_begin(&m, logger, mesh);
    glbk__message_text(&m, ": index ");
    glbk__message_count(&m, position % 3);
    glbk__message_text(&m, " of triangle ");
    glbk__message_count(&m, position / 3);
    glbk__message_text(&m, " is ");
    glbk__message_count(&m, index);
    glbk__message_text(&m, ", but the mesh has ");
    glbk__message_count(&m, vertex_count);
    glbk__message_text(&m, vertex_count == 1 ? " vertex" : " vertices");
    logger->log(logger->user, m.text);
}

/* ==== GLSL of src/gl ==== */


static const char *const glbk__glsl_lib_base_bindings_glsl[] = {
    "\nuniform glbk_color_sampler glbk_source;\n"
};

static const char *const glbk__glsl_lib_prelude_glsl[] = {
    "\n#ifdef GL_ES\n"
    "precision highp float;\n"
    "precision highp int;\n"
    "precision highp sampler2D;\n"
    "precision highp sampler3D;\n"
    "precision highp samplerCube;\n"
    "precision highp sampler2DArray;\n"
    "precision highp sampler2DShadow;\n"
    "precision highp sampler2DArrayShadow;\n"
    "precision highp isampler2D;\n"
    "precision highp isampler2DArray;\n"
    "precision highp usampler2D;\n"
    "precision highp usampler2DArray;\n"
    "#endif\n"
    "\n#ifndef GLBK_FLOAT_BITS\n"
    "#error \"GLBK_FLOAT_BITS: 1 where GLBK_FORMAT_COLOR is RGBA32UI, else 0\"\n"
    "#endif\n"
    "\n\n\n#if GLBK_FLOAT_BITS\n"
    "#define glbk_color uvec4\n"
    "#define glbk_color_sampler usampler2D\n"
    "uvec4 glbk_pack(vec4 color){return floatBitsToUint(color);}\n"
    "vec4 glbk_unpack(uvec4 bits){return uintBitsToFloat(bits);}\n"
    "#else\n"
    "#define glbk_color vec4\n"
    "#define glbk_color_sampler sampler2D\n"
    "vec4 glbk_pack(vec4 color){return color;}\n"
    "vec4 glbk_unpack(vec4 color){return color;}\n"
    "#endif\n"
};

static const char *const glbk__glsl_lib_table_glsl[] = {
    "\nivec3 glbk_table_at(uint i)\n"
    "{\n"
    "return ivec3(uvec3(i&1023u,i>>10&1023u,i>>20));\n"
    "}\n"
};

static const char *const glbk__glsl_prog_copy_frag[] = {
    "\n\n\n\n\n#ifndef TO_COLOR\n"
    "#define TO_COLOR 0\n"
    "#endif\n"
    "#if TO_COLOR\n"
    "layout(location=0)out vec4 result;\n"
    "#else\n"
    "layout(location=0)out glbk_color result;\n"
    "#endif\n"
    "\nvoid main()\n"
    "{\n"
    "vec4 color=glbk_unpack(texelFetch(glbk_source,ivec2(gl_FragCoord.xy),0));\n"
    "#if TO_COLOR\n"
    "result=color;\n"
    "#else\n"
    "result=glbk_pack(color);\n"
    "#endif\n"
    "}\n"
};

static const char *const glbk__glsl_prog_screen_vert[] = {
    "\nvoid main()\n"
    "{\n"
    "gl_Position=vec4(gl_VertexID==1?3.: -1.,gl_VertexID==2?3.: -1.,.0,1.);\n"
    "}\n"
};

static const glbk_file glbk__base_files[] = {
    { "lib/base_bindings.glsl", glbk__glsl_lib_base_bindings_glsl, 1, "", "",
      "", "" },
    { "lib/prelude.glsl", glbk__glsl_lib_prelude_glsl, 1, "", "",
      "", "" },
    { "lib/table.glsl", glbk__glsl_lib_table_glsl, 1, "", "",
      "", "" },
    { "prog/copy.frag", glbk__glsl_prog_copy_frag, 1, "base_bindings", "screen.vert",
      "TO_COLOR=0 | TO_COLOR=1", "" },
    { "prog/screen.vert", glbk__glsl_prog_screen_vert, 1, "", "",
      "", "" }
};


/* ==== src/gl/part.h ==== */

/* ---- part: the base's own GLSL, textures and blocks ---- */

GLBK__PART_CODE(base, BASE)

/* ==== src/gl/log.h ==== */

/* ---- log: why a call fails ---- */

GLBK_DEF const char *glbk_result_text(glbk_result result)
{
#define GLBK__TEXT(name, text) text,
    static const char *const texts[] = { GLBK_RESULTS(GLBK__TEXT) };
#undef GLBK__TEXT
    return (unsigned)result < (unsigned)GLBK_RESULT_COUNT ? texts[result] : "unknown result";
}

static void glbk__log(const glbk_context *ctx, const char *text)
{
    if (ctx->system.log) ctx->system.log(ctx->system.user, text);
}

static glbk_result glbk__fail(const glbk_context *ctx, glbk_result result, const char *text, const char *name)
{
    glbk__message m;
    m.used = 0;
    glbk__message_text(&m, text);
    glbk__message_text(&m, name);
    glbk__log(ctx, m.text);
    return result;
}

/* "TEXT 0x0502": hexadecimal with four digits at least, as GL's constants are known. */
static void glbk__log_constant(const glbk_context *ctx, const char *text, uint32_t value)
{
    char digits[16];
    int at = 15;
    digits[15] = 0;
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

GLBK__DEF glbk_result glbk__refuse_index(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *mesh, size_t position, size_t index, size_t vertex_count)
{
    const glbk__logger logger = glbk__logger_of(ctx, function);
    glbk__log_index(&logger, mesh, position, index, vertex_count);
    return result;
}

/* ==== src/gl/errors.h ==== */

/* ---- errors: GL's error flag ---- */

enum { GLBK__OUT_OF_MEMORY = 0x0505, GLBK__CONTEXT_LOST = 0x0507 };

/* Takes all errors that GL keeps; there may be one for each part of a distributed driver. The count is
   bounded since a driver without a context may return an error for ever. */
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

/* Every function that can fail and calls GL begins and ends with these. */
GLBK__DEF glbk_result glbk__enter(glbk_context *ctx)
{
    if (!ctx) return GLBK_ERR_ARGUMENT;
    return ctx->lost ? GLBK_ERR_LOST : glbk__take_errors(ctx, GLBK_ERR_PENDING);
}

GLBK__DEF glbk_result glbk__leave(glbk_context *ctx) { return glbk__take_errors(ctx, GLBK_ERR_GL); }

/* The same of a frame's calls, which ask GL only where the user wants it: its answer makes browsers and
   drivers with threads of their own wait for all that was asked of them before. */
static glbk_result glbk__enter_frame(glbk_context *ctx)
{
    if (!ctx || ctx->check) return glbk__enter(ctx);
    return ctx->lost ? GLBK_ERR_LOST : GLBK_OK;
}

GLBK__DEF glbk_result glbk__leave_frame(glbk_context *ctx) { return ctx->check ? glbk__leave(ctx) : GLBK_OK; }

/* The end of a creating call whose last steps were a frame's. */
GLBK__DEF glbk_result glbk__leave_created(glbk_context *ctx, glbk_result result)
{
    return result == GLBK_OK ? glbk__leave(ctx) : result;
}

GLBK__DEF glbk_result glbk__check_bound(const glbk_context *ctx, const char *function)
{
    int32_t bound = 0;
    if (!ctx->check || !ctx->inner) return GLBK_OK;
    ctx->gl.GetIntegerv(0x8CA6 /* DRAW_FRAMEBUFFER_BINDING */, &bound);
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
    GLBK__GROUP_CORE, GLBK__GROUP_ES, GLBK__GROUP_DESK, GLBK__GROUP_TARGETS, GLBK__GROUP_BLENDS,
    GLBK__GROUP_COMPUTE, GLBK__GROUP_CLIP, GLBK__GROUP_CLAMP
};

/* The names one after the other, each ended by 0, and their groups, in the order of glbk_functions, which
   holds nothing but pointers to them: a table of pointers to names would be six times as large in a program
   that can be moved. */
static const char glbk__function_names[] =
#define GLBK__ENTRY(group, type, name, parameters) "gl" #name "\0"
    GLBK_FUNCTIONS(GLBK__ENTRY);
#undef GLBK__ENTRY

static const uint8_t glbk__function_groups[] = {
#define GLBK__ENTRY(group, type, name, parameters) GLBK__GROUP_##group,
    GLBK_FUNCTIONS(GLBK__ENTRY)
#undef GLBK__ENTRY
};

/* Loads one group. Returns the name of a function that is missing, or NULL. */
static const char *glbk__load(glbk_context *ctx, const glbk_desc *desc, int group)
{
    const char *next = glbk__function_names;
    size_t i;
    for (i = 0; i < sizeof glbk__function_groups; i++) {
        const char *name = next;
        glbk_proc_fn proc;
        next += strlen(next) + 1;
        if (glbk__function_groups[i] != group) continue;
        if (strcmp(name, "glBarrier") == 0) name = "glMemoryBarrier";
        if (group == GLBK__GROUP_CLIP && ctx->es) name = "glClipControlEXT";
        proc = desc->get_proc_fn(name, desc->user);
        if (!proc) return name;
        memcpy((char *)&ctx->gl + i * sizeof proc, &proc, sizeof proc);
    }
    return NULL;
}

/* "4.5 (Core Profile) ...", "OpenGL ES 3.0 ...", "OpenGL ES 3.0 (WebGL 2.0 ...)": the first number is the
   version. */
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

static uint32_t glbk__get_integer(const glbk_context *ctx, uint32_t name)
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
    origin = glbk__get_integer(ctx, 0x935C /* CLIP_ORIGIN */);
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
    ctx->compute =
        desk && ctx->version >= 430 && !desc->core_only && !glbk__load(ctx, desc, GLBK__GROUP_COMPUTE);
    ctx->clip_control = glbk__has_clip_control(ctx, desc);
    ctx->each_target = desk || (es32 && !glbk__load(ctx, desc, GLBK__GROUP_TARGETS));
    ctx->each_blend =
        ctx->each_target && (es32 || ctx->version >= 400) && !glbk__load(ctx, desc, GLBK__GROUP_BLENDS);
    ctx->offset_clamp = desk &&
                        (ctx->version >= 460 || glbk__has_extension(ctx, "GL_ARB_polygon_offset_clamp")) &&
                        !glbk__load(ctx, desc, GLBK__GROUP_CLAMP);
    ctx->max_side = glbk__get_integer(ctx, 0x0D33);
    ctx->max_layers = glbk__get_integer(ctx, 0x88FF);
    ctx->max_targets = glbk__get_integer(ctx, 0x8824 /* MAX_DRAW_BUFFERS */);
    if (ctx->max_targets > 8) ctx->max_targets = 8;
    if (ctx->compute) ctx->max_storage = glbk__get_integer(ctx, 0x90DE /* MAX_SHADER_STORAGE_BLOCK_SIZE */);
    ctx->gl.GetFloatv(0x846D /* ALIASED_POINT_SIZE_RANGE */, points);
    ctx->max_point_side = points[1];
}

/* Whether `least` bindings from `first` on are among those that the context has; *out: how many, up to
   `most`. */
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
    if (missing) return glbk__fail(ctx, GLBK_ERR_FUNCTION, "glbk_init: missing: ", missing);
    version = (const char *)ctx->gl.GetString(0x1F02);
    if (!version) return GLBK_ERR_CONTEXT;
    result = glbk__take_errors(ctx, GLBK_ERR_PENDING);
    if (result != GLBK_OK) return result;
    glbk__read_version(ctx, version);
    if (ctx->version < (ctx->es ? 300u : 330u))
        return glbk__fail(ctx, GLBK_ERR_OLD_CONTEXT, "glbk_init: this is OpenGL ", version);
    missing = glbk__load(ctx, desc, ctx->es ? GLBK__GROUP_ES : GLBK__GROUP_DESK);
    if (!missing && !ctx->es) missing = glbk__load(ctx, desc, GLBK__GROUP_TARGETS);
    if (missing) return glbk__fail(ctx, GLBK_ERR_FUNCTION, "glbk_init: missing: ", missing);
    ctx->renderer = (const char *)ctx->gl.GetString(0x1F01);
    if (!ctx->renderer) ctx->renderer = "";
    glbk__read_features(ctx, desc);
    result = glbk__check_first(ctx, "desc.first_unit", desc->first_unit, glbk__get_integer(ctx, 0x8B4D),
                               GLBK_UNITS, GLBK_MAX_UNITS, &ctx->unit_count);
    if (result == GLBK_OK)
        result = glbk__check_first(ctx, "desc.first_block", desc->first_block, glbk__get_integer(ctx, 0x8A2F),
                                   GLBK_BLOCKS, GLBK_MAX_BLOCKS, &ctx->block_count);
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
        result = glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "desc.get_proc_fn", "is NULL");
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

/* ---- textures ---- */

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

typedef struct glbk__format_info {
    int32_t  internal;
    uint32_t format, type, bytes;           /* a texel */
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

/* Row lengths, offsets, byte order and pixel buffers that a user left behind would change what GL reads or
   writes. */
enum { GLBK__UNPACK, GLBK__PACK, GLBK__STORE_COUNT = 8 };

typedef struct glbk__store {
    int32_t value[GLBK__STORE_COUNT], buffer;
} glbk__store;

static const uint32_t glbk__store_names[2][GLBK__STORE_COUNT] = {
    /* alignment, row length, skip rows, skip pixels; then image height, skip images; then swap bytes, LSB
       first */
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
    for (i = 0; i < glbk__store_count(ctx, way); i++)
        ctx->gl.PixelStorei(glbk__store_names[way][i], old->value[i]);
    ctx->gl.BindBuffer(glbk__store_buffer[way][0], (uint32_t)old->buffer);
}

static uint32_t glbk__binding_of(uint32_t gl_target)
{
    return gl_target == GLBK_GL_TEXTURE_2D ? 0x8069u : 0x8C1Du;
}

static uint32_t glbk__all_levels(uint32_t width, uint32_t height)
{
    uint32_t side = width > height ? width : height, levels = 1;
    while (side > 1) side /= 2, levels++;
    return levels;
}

/* What a format allows of the sampling; of its own values the desc is right. */
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
        return GLBK_ERR_FLOAT_TARGET;           /* glGenerateMipmap is for what can be rendered to */
    return GLBK_OK;
}

/* A size: 0 is a mistake of the desc's where there must be some, more than the context has is beyond its
   limit. */
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

static uint32_t glbk__half(uint32_t size, uint32_t level) { return size >> level ? size >> level : 1; }

/* ES and WebGL: storage that is allotted once. Of other textures no level may be drawn to while only those
   below it are seen (BASE_LEVEL, MAX_LEVEL), as is done where a pyramid is made. */
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
    /* LINEAR_MIPMAP_LINEAR, LINEAR, NEAREST_MIPMAP_NEAREST, NEAREST */
    const int smaller = mipmaps ? 0x2703 : linear ? 0x2601 : d->levels > 1 ? 0x2700 : 0x2600;
    uint32_t level;

    /* Parameters first: Mesa allots levels by them, and else forgets some of small arrays of integers. */
    ctx->gl.TexParameteri(target, 0x813D /* MAX_LEVEL */, (int32_t)d->levels - 1);
    ctx->gl.TexParameteri(target, 0x2801 /* MIN_FILTER */, smaller);
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

    if (!out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    result = glbk__enter(ctx);
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

static void glbk__upload_box(const glbk_context *ctx, const glbk_texture *t, uint32_t level, uint32_t x,
                             uint32_t y, uint32_t layer, uint32_t width, uint32_t height, uint32_t layers,
                             const void *data)
{
    const glbk__format_info *f = &glbk__formats[t->format];
    if (t->layers)
        ctx->gl.TexSubImage3D(t->gl_target, (int32_t)level, (int32_t)x, (int32_t)y, (int32_t)layer,
                              (int32_t)width, (int32_t)height, (int32_t)layers, f->format, f->type, data);
    else
        ctx->gl.TexSubImage2D(t->gl_target, (int32_t)level, (int32_t)x, (int32_t)y, (int32_t)width,
                              (int32_t)height, f->format, f->type, data);
}

/* Where a run of texels or layers ends. */
static glbk_result glbk__check_span(const glbk_context *ctx, const char *function, const char *field,
                                    uint64_t end, uint64_t most)
{
    return end <= most
               ? GLBK_OK
               : glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, function, field, (double)end, 0, (double)most);
}

GLBK_DEF glbk_result glbk_texture_update(glbk_context *ctx, const glbk_texture *t, uint32_t level, uint32_t x,
                                         uint32_t y, uint32_t layer, uint32_t width, uint32_t height,
                                         uint32_t layers, const void *data)
{
    glbk__upload old;
    glbk_result result = glbk__enter_frame(ctx);

    if (result != GLBK_OK) return result;
    if (!t || !t->name) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "texture", "was not created");
    if (!data) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "data", "is NULL");
    if (level >= t->levels)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "level", level, 0, (double)t->levels - 1);
    result = glbk__check_span(ctx, __func__, "x + width", (uint64_t)x + width, glbk__half(t->width, level));
    if (result == GLBK_OK)
        result =
            glbk__check_span(ctx, __func__, "y + height", (uint64_t)y + height, glbk__half(t->height, level));
    if (result == GLBK_OK)
        result = glbk__check_span(ctx, __func__, "layer + layers", (uint64_t)layer + layers,
                                  t->layers ? t->layers : 1);
    if (result != GLBK_OK) return result;
    glbk__upload_begin(ctx, t, &old);
    glbk__upload_box(ctx, t, level, x, y, layer, width, height, layers, data);
    glbk__upload_end(ctx, t, &old);
    return glbk__leave_frame(ctx);
}

GLBK_DEF void glbk_texture_free(glbk_context *ctx, glbk_texture *texture)
{
    if (!texture) return;
    if (ctx && !ctx->lost && texture->name) ctx->gl.DeleteTextures(1, &texture->name);
    memset(texture, 0, sizeof *texture);
}

/* ==== src/gl/tables.h ==== */

/* ---- tables: texel i at (i & 1023, i >> 10 & 1023, i >> 20) ---- */

enum { GLBK__TABLE_BITS = 10, GLBK__TABLE_SIDE = 1 << GLBK__TABLE_BITS };

GLBK__DEF glbk_result glbk__table_create(glbk_context *ctx, glbk_format format, const void *texels,
                                         size_t count, glbk_texture *out)
{
    const size_t side = GLBK__TABLE_SIDE;
    glbk_texture_desc d;
    glbk_result result;
    size_t rows;

    if (!out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (ctx->lost) return GLBK_ERR_LOST;
    rows = count ? (count - 1) / side + 1 : 0;
    if (!count || (rows - 1) / side >= ctx->max_layers)
        return glbk__refuse_range(ctx, count ? GLBK_ERR_LIMIT : GLBK_ERR_ARGUMENT, __func__, "count",
                                  (double)count, 1, (double)ctx->max_layers * 1048576.0);
    memset(&d, 0, sizeof d);
    d.format = format;
    d.width = GLBK__TABLE_SIDE;
    d.height = (uint32_t)(rows < side ? rows : side);
    d.layers = (uint32_t)((rows - 1) / side + 1);
    result = glbk_texture_create(ctx, &d, out);
    if (result == GLBK_OK && texels)
        result = glbk__leave_created(ctx, glbk__table_update(ctx, out, 0, count, texels));
    if (result != GLBK_OK) glbk_texture_free(ctx, out);
    return result;
}

/* A run of texels is up to three boxes in each layer: the rest of a row, whole rows, the beginning of a
   row. */
GLBK__DEF glbk_result glbk__table_update(glbk_context *ctx, const glbk_texture *table, size_t first,
                                         size_t count, const void *texels)
{
    const size_t side = GLBK__TABLE_SIDE;
    const unsigned char *from = (const unsigned char *)texels;
    glbk__upload old;
    size_t room;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!table || !table->name || table->width != side || !table->layers)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "table", "was not made by glbk__table_create");
    if (!texels) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "texels", "is NULL");
    room = side * table->height * table->layers;
    if (first > room)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "first", (double)first, 0, (double)room);
    if (count > room - first)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "count", (double)count, 0,
                                  (double)(room - first));
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
        glbk__upload_box(ctx, table, 0, (uint32_t)x, (uint32_t)y, (uint32_t)layer, (uint32_t)width,
                         (uint32_t)height, 1, from);
        from += width * height * glbk__formats[table->format].bytes;
        first += width * height;
        count -= width * height;
    }
    glbk__upload_end(ctx, table, &old);
    return glbk__leave_frame(ctx);
}

/* ==== src/gl/buffers.h ==== */

/* ---- buffers: through the copy target, which no vertex array or draw looks at ---- */

enum { GLBK__DYNAMIC_DRAW = 0x88E8 };

static glbk_result glbk__buffer_make(glbk_context *ctx, const char *function, size_t bytes, const void *data,
                                     int indices, glbk_buffer *out)
{
    const uint32_t target = indices ? GLBK_GL_ELEMENT_ARRAY_BUFFER : GLBK_GL_COPY_WRITE_BUFFER;
    int32_t bound = 0;
    glbk_result result;

    if (!out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    result = glbk__enter(ctx);
    if (result != GLBK_OK) return result;
    if (!bytes || bytes > PTRDIFF_MAX)
        return glbk__refuse_range(ctx, bytes ? GLBK_ERR_LIMIT : GLBK_ERR_ARGUMENT, function, "bytes",
                                  (double)bytes, 1, (double)PTRDIFF_MAX);
    ctx->gl.GetIntegerv(indices ? 0x8895 /* ELEMENT_ARRAY_BUFFER_BINDING */ : target, &bound);
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

/* WebGL remembers what a buffer was bound to first. Elsewhere through the copy target as well: this one
   belongs to the vertex array, and core profiles need not have one bound. */
GLBK_DEF glbk_result glbk_indices_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out)
{
    return glbk__buffer_make(ctx, __func__, bytes, data, ctx && ctx->webgl, out);
}

/* Whether a run of bytes lies within a buffer, whose memory is at `memory`. */
static glbk_result glbk__check_run(const glbk_context *ctx, const char *function, const glbk_buffer *buffer,
                                   size_t offset, size_t bytes, const void *memory)
{
    const glbk_result bad = GLBK_ERR_ARGUMENT;
    if (!memory) return glbk__refuse(ctx, bad, function, "the data", "are NULL");
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

    if (result == GLBK_OK) result = glbk__check_run(ctx, __func__, buffer, offset, bytes, data);
    if (result != GLBK_OK) return result;
    ctx->gl.GetIntegerv(target, &bound);
    ctx->gl.BindBuffer(target, buffer->name);
    if (bytes == buffer->bytes) ctx->gl.BufferData(target, (ptrdiff_t)bytes, data, GLBK__DYNAMIC_DRAW);
    else ctx->gl.BufferSubData(target, (ptrdiff_t)offset, (ptrdiff_t)bytes, data);
    ctx->gl.BindBuffer(target, (uint32_t)bound);
    return glbk__leave_frame(ctx);
}

/* All values of a block for the draws that follow, bound to its slot: two calls, which go through the binding
   that a pass changes anyway. The storage is new, so that nothing waits for the draws before, copies what
   they read or, on GPUs that draw tile by tile, splits their pass. */
GLBK__DEF glbk_result glbk__put_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer,
                                      const void *values)
{
    const uint32_t target = GLBK_GL_UNIFORM_BUFFER;
    glbk_result result = glbk__enter_frame(ctx);
    if (ctx->lost || !buffer->name) return ctx->lost ? GLBK_ERR_LOST : GLBK_ERR_ARGUMENT;
    /* Even so: a callback may draw in spite of an error. */
    ctx->gl.BindBufferBase(target, ctx->first_block + slot, buffer->name);
    if (result != GLBK_OK) return result;
    ctx->gl.BufferData(target, (ptrdiff_t)buffer->bytes, values, GLBK_GL_STREAM_DRAW);
    return glbk__leave_frame(ctx);
}

GLBK_DEF glbk_result glbk_buffer_read(glbk_context *ctx, const glbk_buffer *buffer, size_t offset,
                                      size_t bytes, void *out)
{
    int32_t bound = 0;
    glbk_result result = glbk__enter(ctx);

    if (result == GLBK_OK) result = glbk__check_run(ctx, __func__, buffer, offset, bytes, out);
    if (result != GLBK_OK) return result;
    if (ctx->es) return GLBK_ERR_FEATURE;
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

/* ---- targets ---- */

/* Checks one attachment and takes its size, which all have in common. */
static glbk_result glbk__check_attachment(const glbk_context *ctx, const glbk_target_desc *d, uint32_t i,
                                          glbk_target *out)
{
    static const char function[] = "glbk_target_create";
    static const char *const names[] = { "desc.color[0]", "desc.color[1]", "desc.color[2]", "desc.color[3]",
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
    if (glbk__is_float(t->format) && !ctx->float_targets) return GLBK_ERR_FLOAT_TARGET;
    if (out->width && (out->width != glbk__half(t->width, d->level) ||
                       out->height != glbk__half(t->height, d->level)))
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, names[i],
                            "is of another size than those before it");
    out->width = glbk__half(t->width, d->level);
    out->height = glbk__half(t->height, d->level);
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

/* Without colours, a framebuffer is complete in OpenGL 3.3 only where none is to be read from either; 4.1
   dropped that. */
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
    if (!desc) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "desc", "is NULL");
    result = glbk__check_target(ctx, desc, out);
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

/* A texture and the target that is drawn to it. */
GLBK__DEF glbk_result glbk__canvas(glbk_context *ctx, glbk_format format, uint32_t width, uint32_t height,
                                   const glbk_texture *depth, glbk_texture *texture, glbk_target *target)
{
    glbk_texture_desc d;
    glbk_target_desc t;
    glbk_result result;
    if (!width || !height)
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, "a picture", width ? "height" : "width", 0,
                                  "1 or more");
    memset(&d, 0, sizeof d);
    memset(&t, 0, sizeof t);
    d.format = format;
    d.width = width;
    d.height = height;
    t.color[0] = texture;
    t.depth = depth;
    result = glbk_texture_create(ctx, &d, texture);
    return result == GLBK_OK ? glbk__target_create(ctx, &t, target) : result;
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
    bytes = ctx->es && !integer && !glbk__is_float(target->format[attachment]);     /* ES gives no floats of
                                                                                       these */
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

GLBK_DEF void glbk_target_free(glbk_context *ctx, glbk_target *target)
{
    if (!target) return;
    if (ctx && !ctx->lost && target->name) ctx->gl.DeleteFramebuffers(1, &target->name);
    if (ctx && ctx->inner == target->name) ctx->inner = 0;
    memset(target, 0, sizeof *target);
}

/* ==== src/gl/glsl.h ==== */

/* ---- glsl: the text of a program ---- */

enum { GLBK__MAX_FILES = 32 };

/* "lib/" + "table" + ".glsl" = "lib/table.glsl"; length counts the middle. */
static int glbk__is_named(const char *name, const char *before, const char *middle, size_t length,
                          const char *after)
{
    size_t n = strlen(before);
    return strncmp(name, before, n) == 0 && strncmp(name + n, middle, length) == 0 &&
           strcmp(name + n + length, after) == 0;
}

static const glbk_file *glbk__find_in(const glbk_part *part, const char *before, const char *middle,
                                      size_t length, const char *after)
{
    uint32_t i;
    for (i = 0; i < part->file_count; i++)
        if (glbk__is_named(part->files[i].name, before, middle, length, after)) return &part->files[i];
    return NULL;
}

GLBK_DEF const glbk_file *glbk_find_file(const glbk_part *part, const char *name)
{
    const glbk_file *file = part && name ? glbk__find_in(part, "", name, strlen(name), "") : NULL;
    return file || !name ? file : glbk__find_in(glbk_base_part(), "", name, strlen(name), "");
}

/* Library files in the order in which they are compiled, and where they are looked for: the shader's parts,
   then the base. */
typedef struct glbk__list {
    const glbk_file *file[GLBK__MAX_FILES];
    uint32_t         count;
    const glbk_part *parts[GLBK_MAX_PARTS + 1];
} glbk__list;

static const glbk_file *glbk__find_listed(const glbk__list *list, const char *before, const char *middle,
                                          size_t length, const char *after)
{
    const glbk_file *file = NULL;
    uint32_t i;
    for (i = 0; i <= GLBK_MAX_PARTS && !file; i++)
        if (list->parts[i]) file = glbk__find_in(list->parts[i], before, middle, length, after);
    return file;
}

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

/* Adds a library file after what it uses itself, unless it is there. The depth is that of the embedded files,
   which tests/gl_backend/backend_test.c walks. */
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
        if (!glbk__gather_file(list, glbk__find_listed(list, "lib/", names, length, ".glsl"))) return 0;
    return 1;
}

/* Uniform blocks that a text names. No others are declared, since
   what is declared needs a buffer whether it is read or not (std140; WebGL 2 refuses to draw). */
static int glbk__gather_blocks(glbk__list *list, const glbk_part *part, const char *text)
{
    uint32_t i;
    for (i = 0; i < part->file_count; i++) {
        const char *name = part->files[i].block, *at = text;
        size_t length = strlen(name);
        if (!length) continue;
        while ((at = strstr(at, "glbk_")) != NULL &&
               (strncmp(at, name, length) != 0 || glbk__is_name(at[length])))
            at++;
        if (at && !glbk__gather_file(list, &part->files[i])) return 0;
    }
    return 1;
}

/* The files before a shader's own text. Its main file, or NULL where it has none; 0 where a name is
   unknown. */
static int glbk__gather_all(glbk__list *list, const glbk_shader *shader, const glbk_file **main_file)
{
    uint32_t i;
    int known;
    list->count = 0;
    memcpy(list->parts, shader->parts, sizeof shader->parts);
    list->parts[GLBK_MAX_PARTS] = glbk_base_part();
    *main_file = shader->name ? glbk__find_listed(list, "", shader->name, strlen(shader->name), "") : NULL;
    known = (!shader->name || *main_file) && glbk__gather(list, "prelude") &&
            glbk__gather(list, shader->uses ? shader->uses : "") &&
            glbk__gather(list, *main_file ? (*main_file)->uses : "");
    for (i = 0; i <= GLBK_MAX_PARTS && known && shader->text; i++)
        if (list->parts[i]) known = glbk__gather_blocks(list, list->parts[i], shader->text);
    return known;
}

GLBK__DEF void glbk__append(glbk__sink *sink, const char *text, size_t length)
{
    size_t room = sink->bytes > sink->used + 1 ? sink->bytes - 1 - sink->used : 0;
    if (room > length) room = length;
    if (room) memcpy(sink->out + sink->used, text, room);
    sink->used += length;
}

GLBK__DEF void glbk__append_text(glbk__sink *sink, const char *text)
{
    glbk__append(sink, text, strlen(text));
}

/* "#line n001 n": line 4 of file 3 is 3004 in the driver's messages. Mesa forgets the file number, hence
   the thousands. */
static void glbk__put_line(glbk__sink *sink, uint32_t n)
{
    char digits[] = { (char)('0' + n / 10), (char)('0' + n % 10), 0 };
    const char *number = n < 10 ? digits + 1 : digits;
    glbk__append_text(sink, "#line ");
    glbk__append_text(sink, number);
    glbk__append_text(sink, "001 ");
    glbk__append_text(sink, number);
    glbk__append_text(sink, "\n");
}

GLBK__DEF void glbk__append_file(glbk__sink *sink, const glbk_file *file)
{
    uint32_t i;
    for (i = 0; i < file->text_count; i++) glbk__append_text(sink, file->texts[i]);
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
        glbk__append_text(sink, "#define ");
        glbk__append(sink, defines, name);
        glbk__append_text(sink, " ");
        if (name < length) glbk__append(sink, defines + name + 1, length - name - 1);
        else glbk__append_text(sink, "1");
        glbk__append_text(sink, "\n");
    }
    return 1;
}

GLBK_DEF size_t glbk_write_glsl(glbk_dialect dialect, int float_bits, const glbk_shader *shader, char *out,
                                size_t bytes)
{
    static const char *const versions[] = { "#version 330 core\n", "#version 330 core\n", "#version 300 es\n",
                                            "#version 430 core\n" };
    const glbk_file *main_file;
    glbk__list list;
    glbk__sink sink;
    uint32_t i;

    if ((unsigned)dialect >= GLBK_GLSL_COUNT || !shader || (!out && bytes)) return 0;
    if (!glbk__gather_all(&list, shader, &main_file)) return 0;
    sink.out = out;
    sink.bytes = bytes;
    sink.used = 0;
    glbk__append_text(&sink, versions[dialect]);
    glbk__append_text(&sink, float_bits ? "#define GLBK_FLOAT_BITS 1\n" : "#define GLBK_FLOAT_BITS 0\n");
    if (!glbk__put_defines(&sink, shader->defines ? shader->defines : "")) return 0;
    for (i = 0; i < list.count; i++) {
        glbk__put_line(&sink, i + 1);
        glbk__append_file(&sink, list.file[i]);
    }
    glbk__put_line(&sink, list.count + 1);
    if (main_file) glbk__append_file(&sink, main_file);
    if (shader->text) glbk__append_text(&sink, shader->text);
    if (bytes) out[sink.used < bytes ? sink.used : bytes - 1] = 0;
    return sink.used + 1;
}

/* ==== src/gl/slots.h ==== */

/* ---- slots: which unit or binding each texture and block of a program has ---- */

GLBK__DEF glbk_offset glbk__offset(const glbk_offset *offset)
{
    const glbk_offset none = { 0, 0 };
    return offset ? *offset : none;
}

static const glbk_slot glbk__user_slots[] = {
    { "glbk_user0", GLBK_SLOT_glbk_user0 }, { "glbk_user1", GLBK_SLOT_glbk_user1 },
    { "glbk_user2", GLBK_SLOT_glbk_user2 }, { "glbk_user3", GLBK_SLOT_glbk_user3 }, { NULL, 0 }
};

/* Which name of the parts' lists has a unit or a binding, of those that a program declares. */
typedef struct glbk__holders {
    const char *units[GLBK_MAX_UNITS], *blocks[GLBK_MAX_BLOCKS];
    const char *function;           /* that looks */
} glbk__holders;

static int glbk__declares(const glbk_context *ctx, uint32_t gl_program, const char *name, int is_block)
{
    return is_block ? ctx->gl.GetUniformBlockIndex(gl_program, name) != 0xFFFFFFFFu
                    : ctx->gl.GetUniformLocation(gl_program, name) >= 0;
}

/* "FUNCTION: A and B both have texture unit 3: give one part an offset". */
static glbk_result glbk__refuse_place(const glbk_context *ctx, const glbk__holders *h, const char *first,
                                      const char *second, uint32_t place, int is_block)
{
    glbk__message m;
    m.used = 0;
    glbk__message_text(&m, "and ");
    glbk__message_text(&m, second);
    glbk__message_text(&m,
                       is_block ? " both have the binding of uniform blocks " : " both have texture unit ");
    glbk__message_count(&m, place);
    glbk__message_text(&m, ": give one part an offset");
    return glbk__refuse(ctx, GLBK_ERR_MISMATCH, h->function, first, m.text);
}

/* The names of one list take their places; first: by how much these are moved. */
static glbk_result glbk__take_places(const glbk_context *ctx, uint32_t gl_program, const glbk_slot *s,
                                     uint32_t first, int is_block, glbk__holders *h)
{
    const uint32_t count = is_block ? ctx->block_count : ctx->unit_count;
    const char **holders = is_block ? h->blocks : h->units;
    for (; s->name; s++) {
        if (!glbk__declares(ctx, gl_program, s->name, is_block)) continue;
        if (first >= count || s->slot >= count - first)
            return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, h->function, s->name, (double)first + s->slot, 0,
                                      (double)count - 1);
        if (holders[first + s->slot])
            return glbk__refuse_place(ctx, h, holders[first + s->slot], s->name,
                                      (is_block ? ctx->first_block : ctx->first_unit) + first + s->slot,
                                      is_block);
        holders[first + s->slot] = s->name;
    }
    return GLBK_OK;
}

static glbk_result glbk__take_part(const glbk_context *ctx, uint32_t gl_program, const glbk_part *part,
                                   const glbk_offset *offset, glbk__holders *h)
{
    glbk_result result = glbk__take_places(ctx, gl_program, part->textures, offset ? offset->unit : 0, 0, h);
    return result == GLBK_OK
               ? glbk__take_places(ctx, gl_program, part->blocks, offset ? offset->block : 0, 1, h)
               : result;
}

/* Whether all that a linked program declares of its parts and the base has a place of its own. */
static glbk_result glbk__check_places(const glbk_context *ctx, const char *function,
                                      const glbk_program *program)
{
    glbk__holders h;
    glbk_result result;
    uint32_t i;
    memset(&h, 0, sizeof h);
    h.function = function;
    result = glbk__take_part(ctx, program->name, glbk_base_part(), NULL, &h);
    if (result == GLBK_OK) result = glbk__take_places(ctx, program->name, glbk__user_slots, 0, 0, &h);
    for (i = 0; i < GLBK_MAX_PARTS && result == GLBK_OK; i++)
        if (program->parts[i] && program->parts[i] != glbk_base_part())
            result = glbk__take_part(ctx, program->name, program->parts[i], &program->offsets[i], &h);
    return result;
}

static void glbk__set_units(const glbk_context *ctx, const glbk_slot *s, uint32_t first, uint32_t gl_program)
{
    for (; s->name; s++) {
        int32_t location = ctx->gl.GetUniformLocation(gl_program, s->name);
        if (location >= 0) ctx->gl.Uniform1i(location, (int32_t)(ctx->first_unit + first + s->slot));
    }
}

static void glbk__set_part_slots(const glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                 uint32_t gl_program)
{
    const uint32_t first = ctx->first_block + (offset ? offset->block : 0);
    const glbk_slot *s;
    glbk__set_units(ctx, part->textures, offset ? offset->unit : 0, gl_program);
    for (s = part->blocks; s->name; s++) {
        uint32_t index = ctx->gl.GetUniformBlockIndex(gl_program, s->name);
        if (index != 0xFFFFFFFFu) ctx->gl.UniformBlockBinding(gl_program, index, first + s->slot);
    }
}

/* The base's, and those of a user's own samplers, which have slots behind the library's. */
static void glbk__set_base_slots(const glbk_context *ctx, uint32_t gl_program)
{
    glbk__set_part_slots(ctx, glbk_base_part(), NULL, gl_program);
    glbk__set_units(ctx, glbk__user_slots, 0, gl_program);
}

/* Uniforms can be set in the program in use alone before OpenGL 4.1: another one is put back. If it was to be
   deleted once it is no longer in use, GL has done so by now, and none is in use. */
GLBK_DEF glbk_result glbk_set_slots(glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                    uint32_t gl_program)
{
    glbk__holders h;
    glbk_result result = GLBK_OK;
    uint32_t used;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (ctx->lost) return GLBK_ERR_LOST;
    if (!gl_program) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "gl_program", "is 0");
    memset(&h, 0, sizeof h);
    h.function = __func__;
    if (part) result = glbk__take_part(ctx, gl_program, part, offset, &h);
    if (result != GLBK_OK) return result;
    used = glbk__get_integer(ctx, 0x8B8D /* CURRENT_PROGRAM */);
    if (used != gl_program) ctx->gl.UseProgram(gl_program);
    glbk__set_base_slots(ctx, gl_program);
    if (part) glbk__set_part_slots(ctx, part, offset, gl_program);
    if (used != gl_program) ctx->gl.UseProgram(ctx->gl.IsProgram(used) ? used : 0);
    return GLBK_OK;
}

GLBK_DEF void glbk_program_use(glbk_context *ctx, glbk_program *program)
{
    uint32_t i;
    if (!ctx || ctx->lost || !program) return;
    ctx->gl.UseProgram(program->name);
    if (program->slots_set) return;
    program->slots_set = 1;
    glbk__set_base_slots(ctx, program->name);
    for (i = 0; i < GLBK_MAX_PARTS; i++)
        if (program->parts[i])
            glbk__set_part_slots(ctx, program->parts[i], &program->offsets[i], program->name);
}

/* ==== src/gl/programs.h ==== */

/* ---- programs ---- */

enum { GLBK__FRAGMENT = 0x8B30, GLBK__VERTEX = 0x8B31, GLBK__COMPUTE = 0x91B9 };

/* What a stage is made of. */
typedef struct glbk__stage {
    uint32_t    type;
    glbk_shader shader;             /* name or text, one of them */
} glbk__stage;

static void glbk__put_number(glbk__sink *sink, uint32_t value)
{
    glbk__message m;
    m.used = 0;
    glbk__message_count(&m, value);
    glbk__append(sink, m.text, m.used);
}

/* Which number of the driver's messages is which file. */
static void glbk__put_files(glbk__sink *sink, const glbk_shader *shader)
{
    const glbk_file *main_file;
    glbk__list list;
    uint32_t i;

    (void)glbk__gather_all(&list, shader, &main_file);      /* all are there: the text was compiled */
    glbk__append_text(sink, "files: 0 defines");
    for (i = 0; i <= list.count; i++) {
        glbk__append_text(sink, ", ");
        glbk__put_number(sink, i + 1);
        glbk__append_text(sink, " ");
        glbk__append_text(sink, i < list.count ? list.file[i]->name
                                : shader->name ? shader->name
                                               : "your text");
    }
    glbk__append_text(sink, "\n");
}

/* The driver's words on a shader, behind the list of its files, or on a program: shader is NULL then. */
static void glbk__log_driver(const glbk_context *ctx, uint32_t object, const glbk_shader *shader)
{
    glbk__allocator memory = glbk__memory(ctx);
    glbk__sink sink = { NULL, 0, 0 };
    int32_t length = 0;

    if (!ctx->system.log) return;
    if (shader) ctx->gl.GetShaderiv(object, 0x8B84 /* INFO_LOG_LENGTH */, &length);
    else ctx->gl.GetProgramiv(object, 0x8B84, &length);
    if (length < 0) length = 0;
    if (shader) glbk__put_files(&sink, shader);
    sink.bytes = sink.used + (size_t)length + 2;
    sink.out = (char *)glbk__alloc(&memory, sink.bytes);
    if (!sink.out) {
        glbk__log(ctx, "no memory for the driver's words");
        return;
    }
    sink.used = 0;
    if (shader) glbk__put_files(&sink, shader);
    memset(sink.out + sink.used, 0, sink.bytes - sink.used);
    if (shader) ctx->gl.GetShaderInfoLog(object, length + 1, NULL, sink.out + sink.used);
    else ctx->gl.GetProgramInfoLog(object, length + 1, NULL, sink.out + sink.used);
    sink.used = strlen(sink.out);
    while (sink.used && sink.out[sink.used - 1] == '\n') sink.out[--sink.used] = 0;
    glbk__log(ctx, sink.used ? sink.out : "the driver says nothing");
    glbk__free(&memory, sink.out);
}

/* Compiles one stage and attaches it. */
static glbk_result glbk__add_stage(glbk_context *ctx, uint32_t program, const glbk__stage *stage)
{
    glbk_dialect dialect = ctx->es                        ? GLBK_GLSL_300_ES
                           : stage->type == GLBK__COMPUTE ? GLBK_GLSL_430
                                                          : GLBK_GLSL_330;
    glbk__allocator memory = glbk__memory(ctx);
    int bits = !ctx->float_targets;
    size_t bytes = glbk_write_glsl(dialect, bits, &stage->shader, NULL, 0);
    char *text;
    uint32_t shader;
    int32_t compiled = 0;

    if (!bytes)
        return glbk__fail(ctx, GLBK_ERR_NAME,
                          "an unknown library file, or bad defines: ", stage->shader.uses);
    if (bytes > INT32_MAX)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, "a shader", "its text's length", (double)bytes, 1,
                                  INT32_MAX);
    text = (char *)glbk__alloc(&memory, bytes);
    if (!text) return GLBK_ERR_ALLOC;
    glbk_write_glsl(dialect, bits, &stage->shader, text, bytes);
    shader = ctx->gl.CreateShader(stage->type);
    if (shader) {
        const char *const texts[1] = { text };
        ctx->gl.ShaderSource(shader, 1, texts, NULL);
        ctx->gl.CompileShader(shader);
        ctx->gl.GetShaderiv(shader, 0x8B81 /* COMPILE_STATUS */, &compiled);
        if (compiled) {
            ctx->gl.AttachShader(program, shader);
        } else {
            glbk__log_driver(ctx, shader, &stage->shader);
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
        if (count == 16 || length + 1 > sizeof text - used)
            return glbk__refuse(ctx, GLBK_ERR_DESC, "glbk_program_compile", "source.outputs",
                                "has more than 16 names or 511 characters");
        names[count++] = text + used;
        memcpy(text + used, outputs, length);
        text[used + length] = 0;
        used += length + 1;
    }
    if (count) ctx->gl.TransformFeedbackVaryings(program, count, names, GLBK_GL_INTERLEAVED_ATTRIBS);
    return GLBK_OK;
}

static glbk_result glbk__link(glbk_context *ctx, const glbk__stage *stages, int count, const char *outputs,
                              glbk_program *out)
{
    glbk_result result = GLBK_OK, errors;
    int32_t linked = 0;
    int i;

    memcpy(out->parts, stages[0].shader.parts, sizeof out->parts);
    out->name = ctx->gl.CreateProgram();
    if (!out->name) result = GLBK_ERR_GL;
    for (i = 0; i < count && result == GLBK_OK; i++)
        result = glbk__add_stage(ctx, out->name, &stages[i]);
    if (result == GLBK_OK) result = glbk__set_outputs(ctx, out->name, outputs);
    if (result == GLBK_OK) {
        ctx->gl.LinkProgram(out->name);
        ctx->gl.GetProgramiv(out->name, 0x8B82 /* LINK_STATUS */, &linked);
        if (!linked) {
            glbk__log_driver(ctx, out->name, NULL);
            result = GLBK_ERR_LINK;
        }
    }
    errors = glbk__leave(ctx);
    if (errors != GLBK_OK) result = errors;
    if (result != GLBK_OK) glbk_program_free(ctx, out);
    return result;
}

GLBK__DEF glbk_result glbk__program_of_parts(glbk_context *ctx, const glbk_part *part, const glbk_part *other,
                                             const char *name, const char *defines, glbk_program *out)
{
    glbk__stage stages[2];
    const glbk_file *file, *vertex;
    char path[64] = "prog/";
    size_t length;
    glbk_result result;

    if (!out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    result = glbk__enter(ctx);
    if (result != GLBK_OK) return result;
    if (!name) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, "glbk__program_create", "name", "is NULL");
    length = strlen(name);
    if (length < sizeof path - 5) memcpy(path + 5, name, length + 1);
    file = glbk_find_file(part, path);
    if (!file) return glbk__fail(ctx, GLBK_ERR_NAME, "no file prog/", name);
    memset(stages, 0, sizeof stages);
    stages[0].shader.parts[0] = part;
    stages[0].shader.parts[1] = other;
    stages[0].shader.uses = "";
    stages[0].shader.defines = defines;
    stages[1].shader = stages[0].shader;
    stages[0].shader.name = file->name;
    if (length > 5 && strcmp(name + length - 5, ".comp") == 0) {
        if (!ctx->compute) return GLBK_ERR_FEATURE;
        stages[0].type = GLBK__COMPUTE;
        return glbk__link(ctx, stages, 1, "", out);
    }
    strcpy(path + 5, file->with);
    vertex = glbk_find_file(part, path);
    if (!vertex) return glbk__fail(ctx, GLBK_ERR_NAME, "no program: ", name);
    stages[0].type = GLBK__FRAGMENT;
    stages[1].type = GLBK__VERTEX;
    stages[1].shader.name = vertex->name;
    return glbk__link(ctx, stages, 2, "", out);
}

GLBK__DEF glbk_result glbk__program_create(glbk_context *ctx, const glbk_part *part, const char *name,
                                           const char *defines, glbk_program *out)
{
    return glbk__program_of_parts(ctx, part, NULL, name, defines, out);
}

/* The program of a user's text: linked as others, then its parts must not meet. */
static glbk_result glbk__link_source(glbk_context *ctx, const glbk__stage *stages, int count,
                                     const glbk_source *s, glbk_program *out)
{
    glbk_result result = glbk__link(ctx, stages, count, s->outputs && count == 2 ? s->outputs : "", out);
    if (result != GLBK_OK) return result;
    memcpy(out->offsets, s->offsets, sizeof out->offsets);
    result = glbk__check_places(ctx, "glbk_program_compile", out);
    if (result != GLBK_OK) glbk_program_free(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_program_compile(glbk_context *ctx, const glbk_source *s, glbk_program *out)
{
    glbk__stage stages[2];
    glbk_result result;

    if (!out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    result = glbk__enter(ctx);
    if (result != GLBK_OK) return result;
    if (!s) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "source", "is NULL");
    if ((s->fragment != NULL) == (s->compute != NULL))
        return glbk__refuse(ctx, GLBK_ERR_DESC, __func__, "source", "must have one of fragment and compute");
    memset(stages, 0, sizeof stages);
    memcpy(stages[0].shader.parts, s->parts, sizeof s->parts);
    stages[0].shader.uses = s->uses ? s->uses : "";
    stages[0].shader.defines = s->defines;
    stages[1].shader = stages[0].shader;
    if (s->compute) {
        if (!ctx->compute) return GLBK_ERR_FEATURE;
        stages[0].type = GLBK__COMPUTE;
        stages[0].shader.text = s->compute;
        return glbk__link_source(ctx, stages, 1, s, out);
    }
    stages[0].type = GLBK__FRAGMENT;
    stages[0].shader.text = s->fragment;
    stages[1].type = GLBK__VERTEX;
    stages[1].shader.name = s->vertex ? NULL : "prog/screen.vert";
    if (!s->vertex) stages[1].shader.uses = "";     /* a library file may speak of gl_FragCoord */
    stages[1].shader.text = s->vertex;
    return glbk__link_source(ctx, stages, 2, s, out);
}

GLBK_DEF void glbk_program_free(glbk_context *ctx, glbk_program *program)
{
    if (!program) return;
    if (ctx && !ctx->lost && program->name) ctx->gl.DeleteProgram(program->name);
    memset(program, 0, sizeof *program);
}

/* ==== src/gl/state.h ==== */

/* ---- state: what passes touch ----

   GL's name, where it exists, the value that a pass needs. BOTH are in both dialects, DESK in OpenGL alone.
   PROGRAM_POINT_SIZE and MULTISAMPLE are on because ES has no switch for them and behaves so; the rest must
   not interfere. SRGB is for targets alone that have such a format, which ES encodes, too: in the user's
   framebuffer it is a matter of the user's. */

enum { GLBK__CAP_BOTH, GLBK__CAP_DESK, GLBK__CAP_RESTART, GLBK__CAP_SRGB };

static const struct { uint32_t name; int group, value; } glbk__caps[] = {
    { 0x0BE2, GLBK__CAP_BOTH, 0 },      /* BLEND */
    { 0x0B71, GLBK__CAP_BOTH, 0 },      /* DEPTH_TEST */
    { 0x0B44, GLBK__CAP_BOTH, 0 },      /* CULL_FACE */
    { 0x8037, GLBK__CAP_BOTH, 0 },      /* POLYGON_OFFSET_FILL */
    { 0x0C11, GLBK__CAP_BOTH, 0 },      /* SCISSOR_TEST */
    { 0x0B90, GLBK__CAP_BOTH, 0 },      /* STENCIL_TEST */
    { 0x0BD0, GLBK__CAP_BOTH, 0 },      /* DITHER */
    { 0x809E, GLBK__CAP_BOTH, 0 },      /* SAMPLE_ALPHA_TO_COVERAGE */
    { 0x80A0, GLBK__CAP_BOTH, 0 },      /* SAMPLE_COVERAGE */
    { 0x8C89, GLBK__CAP_BOTH, 0 },      /* RASTERIZER_DISCARD */
    { 0x8D69, GLBK__CAP_RESTART, 0 },   /* PRIMITIVE_RESTART_FIXED_INDEX */
    { 0x8F9D, GLBK__CAP_DESK, 0 },      /* PRIMITIVE_RESTART */
    { 0x0BF2, GLBK__CAP_DESK, 0 },      /* COLOR_LOGIC_OP */
    { 0x864F, GLBK__CAP_DESK, 0 },      /* DEPTH_CLAMP */
    { 0x809F, GLBK__CAP_DESK, 0 },      /* SAMPLE_ALPHA_TO_ONE */
    { 0x8E51, GLBK__CAP_DESK, 0 },      /* SAMPLE_MASK */
    { 0x0B41, GLBK__CAP_DESK, 0 },      /* POLYGON_SMOOTH */
    { 0x0B20, GLBK__CAP_DESK, 0 },      /* LINE_SMOOTH */
    { 0x2A02, GLBK__CAP_DESK, 0 },      /* POLYGON_OFFSET_LINE */
    { 0x2A01, GLBK__CAP_DESK, 0 },      /* POLYGON_OFFSET_POINT */
    { 0x8642, GLBK__CAP_DESK, 1 },      /* PROGRAM_POINT_SIZE */
    { 0x809D, GLBK__CAP_DESK, 1 },      /* MULTISAMPLE */
    { 0x8DB9, GLBK__CAP_SRGB, 1 },      /* FRAMEBUFFER_SRGB */
    { 0x884F, GLBK__CAP_DESK, 1 },      /* TEXTURE_CUBE_MAP_SEAMLESS */
    /* CLIP_DISTANCE0 to 7 */
    { 0x3000, GLBK__CAP_DESK, 0 }, { 0x3001, GLBK__CAP_DESK, 0 }, { 0x3002, GLBK__CAP_DESK, 0 },
    { 0x3003, GLBK__CAP_DESK, 0 }, { 0x3004, GLBK__CAP_DESK, 0 }, { 0x3005, GLBK__CAP_DESK, 0 },
    { 0x3006, GLBK__CAP_DESK, 0 }, { 0x3007, GLBK__CAP_DESK, 0 }
};
enum { GLBK__CAP_COUNT = sizeof glbk__caps / sizeof glbk__caps[0] };

static int glbk__has_cap(const glbk_context *ctx, int i)
{
    if (glbk__caps[i].group == GLBK__CAP_RESTART)
        return ctx->es ? !ctx->webgl : ctx->version >= 430;     /* in WebGL it is always on */
    return glbk__caps[i].group == GLBK__CAP_BOTH || !ctx->es;
}

GLBK__DEF void glbk__set_cap(const glbk_context *ctx, uint32_t name, int on)
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
        ctx->gl.BindImageTexture(i, (uint32_t)m[0], m[1], (uint8_t)(m[2] != 0), m[3], (uint32_t)m[4],
                                 (uint32_t)m[5]);
    }
}

static void glbk__save_bindings(glbk_context *ctx, glbk_state *s)
{
    uint32_t i;
    for (i = 0; i < ctx->unit_count; i++) {
        ctx->gl.ActiveTexture(GLBK_GL_TEXTURE0 + ctx->first_unit + i);
        ctx->gl.GetIntegerv(0x8069 /* TEXTURE_BINDING_2D */, &s->units[i][0]);
        ctx->gl.GetIntegerv(0x8C1D /* TEXTURE_BINDING_2D_ARRAY */, &s->units[i][1]);
        ctx->gl.GetIntegerv(0x8919 /* SAMPLER_BINDING */, &s->units[i][2]);
    }
    ctx->gl.ActiveTexture((uint32_t)s->words[GLBK__W_UNIT]);
    for (i = 0; i < ctx->block_count; i++) {
        ctx->gl.GetIntegeri_v(0x8A28, ctx->first_block + i, &s->blocks[i]);
        ctx->gl.GetInteger64i_v(0x8A29, ctx->first_block + i, &s->ranges[i][0]);
        ctx->gl.GetInteger64i_v(0x8A2A, ctx->first_block + i, &s->ranges[i][1]);
    }
    for (i = 0; i < GLBK_BLOCKS && ctx->compute; i++) {
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

/* ==== src/gl/passes.h ==== */

/* ---- passes ---- */

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
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "pass.viewport",
                            "is empty, and there is no pass.target");
    return GLBK_OK;
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
        ctx->gl.Enable(0x8037);
        ctx->gl.PolygonOffset(pass->offset[0], pass->offset[1]);
    }
    if (!ctx->es) ctx->gl.PolygonMode(0x0408, 0x1B02 /* FILL */);
    if (ctx->clip_control) ctx->gl.ClipControl(0x8CA1 /* LOWER_LEFT */, 0x935E /* NEGATIVE_ONE_TO_ONE */);
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
            memcpy(words, rgba, sizeof words);      /* floats by their bits */
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
    ctx->gl.BindImageTexture(slot, texture->name, 0, texture->layers != 0, 0, 0x88BA /* READ_WRITE */,
                             (uint32_t)glbk__formats[texture->format].internal);
}

GLBK_DEF void glbk_draw_screen(glbk_context *ctx)
{
    if (ctx && !ctx->lost) ctx->gl.DrawArrays(GLBK_GL_TRIANGLES, 0, 3);
}

GLBK_DEF glbk_result glbk_dispatch(glbk_context *ctx, glbk_program *program, uint32_t x, uint32_t y,
                                   uint32_t z)
{
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!program || !program->name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "program", "was not created");
    if (ctx->lost) return GLBK_ERR_LOST;
    if (!ctx->compute) return GLBK_ERR_FEATURE;
    glbk_program_use(ctx, program);
    ctx->gl.DispatchCompute(x, y, z);
    ctx->gl.Barrier(GLBK_GL_ALL_BARRIER_BITS);
    return GLBK_OK;
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
