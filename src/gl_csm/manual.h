/* gl_csm.h - v0.9.0 - coherent shadow maps on OpenGL 3.3, ES 3.0, WebGL 2 - MIT-0 OR Unlicense

   What it does

   It brings the blocks that csm.h built onto the GPU. In shaders of your own csm_visible() says whether a
   point is lit; many questions are answered at once; a complete Monte Carlo renderer adds up direct light;
   and blocks are built from layers that the GPU draws.

   What it does not do

   - It needs gl_gbuffer.h beside it, which holds what the renderer shades; gl_programs.h, which makes
     programs; and gl_backend.h, which makes the context object, textures and targets, and whose conventions,
     errors and rules about GL's state hold here.
   - It has no blocks, lights or materials of its own: csm.h builds the blocks, or reads them from files, and
     lights and materials are those of lightsampling.h. Both headers are included; their implementations are
     not needed.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #define GL_CSM_IMPLEMENTATION
       #include "gl_backend/gl_csm.h"
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
               "    cohsm_query query = cohsm_ask(COHSM_LIGHT_POSITION, COHSM_FILTER_NEAREST, 1.0);\n"
               "    color = vec4(csm_visible(0u, query, place, vec3(0.0, 3.0, 0.0)));\n"
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
           source.parts[0] = glbk_csm_part();               // the GLSL of this header
           source.uses = "csm_visible";
           source.defines = NULL;
           source.fragment = fragment;
           result = glbk_program_compile(&gl, &source, &program);
           printf("%s\n", glbk_result_text(result));
           glbk_program_free(&gl, &program);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   The whole frame, with a window: examples/06_csm_gl_minimal.c.

   Vectors

   A vector that is said to be unit may have a length of 0.97 to 1.03 and is used as it is, and any other
   length is an error; in shaders of your own nothing is checked.

   From the paper to the code

   The paper is that of csm.h and lightsampling.h: Ritschel, Grosch, Kautz and Mueller, "Interactive
   Illumination with Coherent Shadow Maps", EGSR 2007. A line has the function in GLSL or the call, its twin
   in csm.h or lightsampling.h, and the rows of docs/conformance.md that test both.

     section 3.1  layers, view by view            glbk_csm_builder_draw      cohsm_builder_add       -
     eq. (1)      segments: one depth for many    glbk_csm_builder_compress  cohsm__compress_view    -
     section 3.2  project, find segment, compare  cohsm_see, cohsm_pixel     cohsm__project_point    T61 T66
     section 3.2  the search for a segment        cohsm_list_depth           cohsm__block_find       T61
     section 3.3  six faces of a cube             cohsm_face_coordinates     cohsm__face_of          T70
     section 4    D, where the maps look from     cohsm_map_parameter        cohsm__map_parameter    T73
     section 4.1  from a direction to its map     cohsm_domain_position      cohsm__domain_position  T43 T73
     section 4.3  lights outside the convex hull  cohsm_hull                 cohsm__light_refused    T67 T68
     section 4.5  filtering                       cohsm_pcf                  cohsm__pcf              T69
     section 4.5  Russian roulette                cohsm_jitter               cohsm__jitter           -
     section 4.6  several objects, D times T^-1   cohsm_visible_scene        cohsm_visible_scene     T62 T66
     section 5    A and L, shape and radiance     cohsm_light_draw           lsamp_light_sample      -
     section 5.1  the mean of f L V cos / p       cohsm_estimate             lsamp__estimate         -
     section 5.1  P_L, the inverse of a CDF       cohsm_pick_coords          lsamp__invert_sums      -
     section 5.1  P_f, lobes by Russian roulette  cohsm_brdf_draw            lsamp__brdf_draw        -
     section 5.1  256 patterns, one for a pixel   cohsm_numbers              lsamp__random_numbers   -
     section 5.2  the mean of frames              glbk_csm_resolve           lsamp_progressive_add   -

   Lines without a row are compared with their twins: by tests/csm/gl_build_test.c, gl_shade_test.c and
   gl_twin_test.c.

   Configuration

     GL_CSM_IMPLEMENTATION   in one source file: compiles the code; another file may have those of
                             gl_backend.h, gl_programs.h and gl_gbuffer.h

   Layouts: docs/gpu-layouts.md. The technique: docs/csm.md. State: docs/gl-state.md. Licence: end of file. */
/* These stand outside the guard, because a second inclusion of this file may ask for their implementations.
   csm.h and lightsampling.h lie above this folder. */
#include "gl_programs.h"
#include "gl_gbuffer.h"
#include "../csm.h"
#include "../lightsampling.h"

#ifndef GL_CSM_H
#define GL_CSM_H

#if GLBK_VERSION != 900
#error "gl_csm.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_CSM_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_CSM_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif
