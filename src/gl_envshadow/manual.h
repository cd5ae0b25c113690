/* gl_envshadow.h - v0.9.0 - environment-map shadows on OpenGL 3.3, ES 3.0 and WebGL 2 - MIT-0 OR Unlicense

   What it does

   The header draws the shadow maps of a sky's lights, all into one atlas, through a callback of yours.
   Shaders of your own light points with all of them by one call, envsh_light(). Or complete passes light a
   G-buffer, with all lights at once or with clusters of them one after the other.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, textures and targets, and whose
     conventions, errors and rules about GL's state hold here; gl_programs.h, which makes programs;
     and gl_gbuffer.h, for complete passes.
   - It chooses no lights. envlights.h does that, or you do. envshadow.h says where their maps lie and which
     matrices they are drawn with.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #define GL_ENVSHADOW_IMPLEMENTATION
       #include "gl_backend/gl_envshadow.h"
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

   Vectors

   A vector that is said to be unit may have a length of 0.97 to 1.03 and is used as it is; envshadow.h checks
   those of lights, gl_gbuffer.h those of pixels, and in shaders of your own nothing is checked.

   From the paper to the code

   The paper is that of envshadow.h: Knuth and Fuhrmann, "Self-Shadowing of Dynamic Scenes with Environment
   Maps using the GPU", WSCG 2005. A line has the function in GLSL or the call, its twin in envshadow.h, and
   the rows of docs/conformance.md that test both.

     3, algorithm 1, all lights at once  glbk_envsh_shade        envsh_shade             T23
     3, algorithm 2, clusters of lights  glbk_envsh_illuminate   envsh_illuminate        -
     3, Fig. 2, maps side by side        glbk_envsh_maps_render  envsh__lay_out_tiles    T24
     3, Fig. 4, smoothing                envsh_smooth            envsh__filter_smooth    -
     4, Fig. 5, maps in color channels   envsh_lit               envsh__is_lit           T24
     4, percentage closer filtering      envsh_taps              envsh__filter_taps      T24
     6, size of the light source         envsh_penumbra          envsh__filter_penumbra  -

   Lines without a row are compared with their twins by tests/envshadow/gl_twin_test.c.

   Configuration

     GL_ENVSHADOW_IMPLEMENTATION   compiles the code, in one source file; the implementations of
                                   gl_backend.h, gl_programs.h and gl_gbuffer.h may be compiled in another

   Layouts: docs/gpu-layouts.md.   The technique: docs/envshadow.md.   State: docs/gl-state.md.
   Licence: end of file. */
/* These includes stand outside the guard, since an implementation may be asked for when the file is included
   for the second time. envshadow.h lies above this folder. */
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
