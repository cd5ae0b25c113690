/* gl_ism.h - v0.9.0 - imperfect shadow maps on OpenGL 3.3, OpenGL ES 3.0 and WebGL 2 - MIT-0 OR Unlicense

   What it does

   The header draws the imperfect shadow maps of all VPLs from surfels, fills their holes, and sums the light
   of the VPLs with visibility. Shaders of your own do so by one call, ism_light(). Or complete passes light a
   G-buffer, with interleaved sampling and its blur. Descs, settings and lists are the structs of ism.h, of
   which this header needs the declarations alone.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, programs, textures and targets, and
     whose conventions, errors and rules about GL's state hold here; and gl_gbuffer.h, whose G-buffer is lit.
   - It chooses no VPLs and scatters no surfels: ism.h does.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #define GL_ISM_IMPLEMENTATION
       #include "gl_backend/gl_ism.h"
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
               "    color = ism_light(place, up, up, 0u, 1u);\n"
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
           source.parts[0] = glbk_ism_part();               // the GLSL of this header
           source.uses = "ism_light";
           source.defines = "ISM_PROJECTION=1";
           source.fragment = fragment;
           result = glbk_program_compile(&gl, &source, &program);
           printf("%s\n", glbk_result_text(result));
           glbk_program_free(&gl, &program);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   The whole frame, with a window: examples/10_ism_gl_minimal.c, and examples/10b_rsm_ism_gl_minimal.c by
   complete passes.

   Configuration

     GL_ISM_IMPLEMENTATION   compiles the code, in one source file; the implementations of
                             gl_backend.h and gl_gbuffer.h may be compiled in another

   Layouts: docs/gpu-layouts.md.   The technique: docs/ism.md.   State: docs/gl-state.md.
   Licence: end of file. */
/* These includes stand outside the guard, since an implementation may be asked for when the file is included
   for the second time. ism.h lies above this folder; its implementation is not needed. */
#include "gl_backend.h"
#include "gl_gbuffer.h"
#include "../ism.h"

#ifndef GL_ISM_H
#define GL_ISM_H

#if GLBK_VERSION != 900
#error "gl_ism.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_ISM_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_ISM_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif
