/* gl_rsm.h - v0.9.0 - reflective shadow maps on OpenGL 3.3, OpenGL ES 3.0 and WebGL 2 - MIT-0 OR Unlicense

   What it does

   The header draws reflective shadow maps by calls of yours, or takes those of rsm.h, picks their pixel
   lights, and gathers the light that bounces once. Shaders of your own do so by two calls, rsm_direct() and
   rsm_gather_about(). Or complete passes light a G-buffer, with screen-space interpolation and a filter over
   frames. Lights, descs and settings are the structs of rsm.h and gifilter.h, of which this header needs the
   declarations alone.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, textures and targets, and whose
     conventions, errors and rules about GL's state hold here; gl_programs.h, which makes programs;
     and gl_gbuffer.h, whose G-buffer is lit.
   - Bounced light has no shadows of its own: that of gl_ism.h has.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
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

   A frame by complete passes

       glbk_rsm_map_draw(gl, &r, &map, draw, user);               // or glbk_rsm_map_import, _upload
       glbk_gbuffer_begin(gl, &seen, world_to_clip, eye); ...     // what the camera sees: gl_gbuffer.h
       glbk_rsm_direct(gl, &r, &seen, maps, n, &direct);          // direct light, shadowed by the same maps
       glbk_rsm_gather(gl, &r, &seen, maps, n, &gather);          // bounced light; or glbk_rsm_interpolate
       glbk_rsm_denoise(gl, &r, &seen, &frame, NULL);             // if few samples were taken
       glbk_rsm_resolve(gl, &r, &seen, &pass, NULL, 1, 1);

   In shaders of your own

   These functions of lib/rsm_direct.glsl, lib/rsm_gather.glsl and lib/rsm_sampling.glsl can be called after
   glbk_rsm_bind:

       rsm_light rsm_bound();                      // the light whose map is bound
       rsm_sampling rsm_bound_sampling();          // how glbk_rsm_gather took points last
       vec3 rsm_direct(rsm_light l, vec3 p, vec3 n, int taps, float bias, float slope_bias);
       vec3 rsm_gather_list(rsm_light l, vec3 p, vec3 n, uint from, uint to, bool glossy, float mixed);
       vec3 rsm_gather_about(rsm_light l, vec3 p, vec3 n, rsm_sampling s, vec2 turn, uint first, uint step,
                             uint count);

   p is in world space, n is unit. rsm_direct returns irradiance, W/m^2. The other two return pi times bounced
   irradiance. rsm_gather_list goes through lights from .. to - 1 of the list: all of them are
   glbk_rsm_frame.first_light to end_light, glossy being glbk_rsm_frame.material_count != 0u and mixed
   glbk_rsm_frame.mixed. rsm_gather_about goes through count points first, first + step, ... of the bound
   pattern about p; turn is cosine and sine of a rotation.

   Conventions

   Lights, descs and their defaults are those of rsm.h, those of the filter are gifilter.h's: the same struct
   gives the same light here and there. A field that GL cannot honour is GLBK_ERR_DESC, and the log names the
   field: desc.system and desc.add have to be zero, rsm_interpolation.mask and gifilt_frame.motion NULL. Maps
   come from the CPU (rsm_map_texels, as they are), or they are drawn here through a callback of yours. Pixel
   lights are picked by flux, from running sums that are made here, too.

   A vector that is said to be unit may have a length of 0.97 to 1.03 and is used as it is, so interpolated
   normals must be normalised before they come; directions of lights may have any length.

   Images are RGBA32UI, bits of floats, so that everything works without EXT_color_buffer_float.

   From the paper to the code

   The paper is that of rsm.h: Dachsbacher and Stamminger, "Reflective Shadow Maps", I3D 2005. A line has the
   function in GLSL or the call, its twin in rsm.h, and the rows of docs/conformance.md that test both.

     section 3.1  what a texel stores                   glbk_rsm_map_draw     rsm_rasterize       T34 T35
     section 3.2  flux through a texel                  rsm_incident          rsm_fill            T30 T31 T33
     section 3.2  lights move below their surface       rsm_gather_about      rsm_gather          T38
     eq. (1)      irradiance from one texel             rsm_gather_list       rsm_gather_list     T25 T28 T40
     eq. (2)      the sum over texels                   glbk_rsm_gather       rsm_gather          T32 T44
     section 3.3  a receiver's projection into the map  rsm_to_face           rsm_map_project     -
     eq. (3)      samples about the projection          rsm_gather_about      rsm_gather          T26 T27 T36
     section 4    interpolation between alike samples   glbk_rsm_interpolate  rsm_interpolate     T39
     section 4    direct light by the same map          glbk_rsm_direct       rsm_direct          T29
     figure 6     ambient occlusion as a factor         glbk_rsm_gather       rsm_points          -
     section 6    textures are averaged over a texel    glbk_rsm_object       rsm_mesh            -
     section 7    lamps all round, and area lights      glbk_rsm_map_create   rsm_map_create      T37
     section 7    reflectors that are not diffuse       rsm_gloss             rsm_material        -
     -            near texels are surfaces              rsm_texel_form        rsm_gather          T42

   Configuration

     GL_RSM_IMPLEMENTATION   compiles the code, in one source file; the implementations of
                             gl_backend.h, gl_programs.h and gl_gbuffer.h may be compiled in another

   Layouts: docs/gpu-layouts.md.   The technique: docs/rsm.md.   State: docs/gl-state.md.
   Licence: end of file. */
/* These includes stand outside the guard, since an implementation may be asked for when the file is included
   for the second time. rsm.h and gifilter.h lie above this folder; their implementations are not needed. */
#include "gl_programs.h"
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
