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
