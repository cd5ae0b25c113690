/* gl_shadowfield.h - v0.9.0 - shadow fields on OpenGL 3.3, ES 3.0, WebGL 2 - MIT-0 OR Unlicense

   What it does

   It brings fields of shadowfield.h onto the GPU: shaders of your own call sfield_shade(), a complete pass
   shades a G-buffer, and cubes of new fields are drawn and projected by the GPU.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, programs, textures and targets, and
     whose conventions, errors and rules about GL's state hold here; gl_gbuffer.h, which has what a camera
     sees; and shadowfield.h above it, whose fields and entities it takes and whose functions it calls. The
     implementations of all three belong into some file of the program.
   - It has fields of spherical harmonics only: wavelets and fields of logarithms are shadowfield.h's alone.
   - It has no resolve: light is a texture that your lighting pass multiplies by the surface's colour.

   Quick start

       #define SHADOWFIELD_IMPLEMENTATION
       #define GL_BACKEND_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #define GL_SHADOWFIELD_IMPLEMENTATION
       #include "gl_backend/gl_shadowfield.h"
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
           static const char fragment[] =                   // a shader of yours that calls the library
               "out vec4 color;\n"
               "void main()\n"
               "{\n"
               "    vec3 place = vec3(gl_FragCoord.xy, 0.0), up = vec3(0.0, 1.0, 0.0);\n"
               "    float t[SFIELD_COEFS];\n"
               "    sfield_cosine(up, t);\n"
               "    color = vec4(sfield_shade(place, up, 0u, t, t).light, 1.0);\n"
               "}\n";
           glbk_context gl;
           glbk_program program;
           glbk_desc desc;
           glbk_source source;
           glbk_result result;

           memset(&desc, 0, sizeof desc);
           desc.get_proc_fn = get_proc;                     // a context is current
           result = glbk_init(&gl, &desc);
           if (result != GLBK_OK) {
               printf("no GL: %s\n", glbk_result_text(result));
               return result != GLBK_ERR_FUNCTION;
           }
           memset(&source, 0, sizeof source);
           source.parts[0] = glbk_sfield_part();            // the GLSL of this header
           source.uses = "sfield_shade";
           source.defines = "SFIELD_BANDS=4";
           source.fragment = fragment;
           result = glbk_program_compile(&gl, &source, &program);
           printf("%s\n", glbk_result_text(result));
           glbk_program_free(&gl, &program);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   The whole frame, with a window: examples/09_shadowfield_gl_minimal.c; as complete passes, with own
   visibility: examples/09b_shadowfield_gl_passes.c.

   Configuration

     GL_SHADOWFIELD_IMPLEMENTATION   in one source file: compiles the code; other files may have that of
                                     gl_backend.h, gl_gbuffer.h and shadowfield.h

   Layouts: docs/gpu-layouts.md. The technique: docs/shadowfield.md. State: docs/gl-state.md.
   Licence: end of file. */
/* These stand outside the guard, because a second inclusion of this file may ask for their implementations.
   shadowfield.h lies above this folder. */
#include "gl_gbuffer.h"
#include "../shadowfield.h"

#ifndef GL_SHADOWFIELD_H
#define GL_SHADOWFIELD_H

#if GLBK_VERSION != 900
#error "gl_shadowfield.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_SHADOWFIELD_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_SHADOWFIELD_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif
