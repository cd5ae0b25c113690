/* gl_rsm.h - v0.9.0 - reflective shadow maps on OpenGL 3.3, OpenGL ES 3.0 and WebGL 2 - MIT-0 OR Unlicense

   What it does

   The header draws reflective shadow maps by calls of yours, or takes those of rsm.h, picks their pixel
   lights, and gathers the light that bounces once. Shaders of your own do so by two calls, rsm_direct() and
   rsm_gather_about(). Or complete passes light a G-buffer, with screen-space interpolation and a filter over
   frames. Lights, descs and settings are the structs of rsm.h and gifilter.h, of which this header needs the
   declarations alone.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, programs, textures and targets, and
     whose conventions, errors and rules about GL's state hold here; and gl_gbuffer.h, whose G-buffer is lit.
   - Bounced light has no shadows of its own: that of gl_ism.h has.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #define GL_RSM_IMPLEMENTATION
       #include "gl_backend/gl_rsm.h"
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
               "    color = vec4(rsm_direct(rsm_bound(), place, up, 4, 1.0, 1.0), 1.0);\n"
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
           source.parts[0] = glbk_rsm_part();               // the GLSL of this header
           source.uses = "rsm_direct";
           source.defines = NULL;
           source.fragment = fragment;
           result = glbk_program_compile(&gl, &source, &program);
           printf("%s\n", glbk_result_text(result));
           glbk_program_free(&gl, &program);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   The whole frame, with a window: examples/07_rsm_gl_minimal.c.

   Configuration

     GL_RSM_IMPLEMENTATION   compiles the code, in one source file; the implementations of
                             gl_backend.h and gl_gbuffer.h may be compiled in another

   Layouts: docs/gpu-layouts.md.   The technique: docs/rsm.md.   State: docs/gl-state.md.
   Licence: end of file. */
/* These includes stand outside the guard, since an implementation may be asked for when the file is included
   for the second time. rsm.h and gifilter.h lie above this folder; their implementations are not needed. */
#include "gl_backend.h"
#include "gl_gbuffer.h"
#include "../rsm.h"
#include "../gifilter.h"

#ifndef GL_RSM_H
#define GL_RSM_H

#if GLBK_VERSION != 900
#error "gl_rsm.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_RSM_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_RSM_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif
