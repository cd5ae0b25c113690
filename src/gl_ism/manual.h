/* gl_ism.h - v0.9.0 - imperfect shadow maps on OpenGL 3.3, OpenGL ES 3.0 and WebGL 2 - MIT-0 OR Unlicense

   What it does

   The header draws the imperfect shadow maps of all VPLs from surfels, fills their holes, and sums the light
   of the VPLs with visibility. Shaders of your own do so by one call, ism_light(). Or complete passes light a
   G-buffer, with interleaved sampling and its blur. Descs, settings and lists are the structs of ism.h, of
   which this header needs the declarations alone.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, textures and targets, and whose
     conventions, errors and rules about GL's state hold here; gl_programs.h, which makes programs;
     and gl_gbuffer.h, whose G-buffer is lit.
   - Skies' VPLs come from ism.h. VPLs, near points and the windows of tiles are chosen by ism.h or, from maps
     on the GPU, by glbk_ism_choose; surfels are scattered by ism.h or by glbk_ism_scatter.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
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

   A frame, after ism_choose and ism_scatter

       glbk_ism_surfels_upload(gl, &maps, phase, surfels, m);       // of ism_phase_surfels; at first all
       glbk_ism_vpls_upload(gl, &maps, vpls, n, &info);             // of ism_vpls and ism_get_info
       glbk_ism_near_points_upload(gl, &maps, points, count);       // of ism_near_points
       glbk_ism_mesh_move(gl, &maps, positions, 0);                 // if vertices moved
       glbk_ism_draw(gl, &maps, 0);
       glbk_gbuffer_begin(gl, &seen, world_to_clip, eye); ...       // what the camera sees: gl_gbuffer.h
       glbk_ism_shade(gl, &renderer, &seen, &maps, NULL, 0);
       glbk_ism_resolve(gl, &renderer, &seen, &pass, NULL);

   With a source in textures, such as glbk_rsm_map.texels, two calls take the place of the first three and of
   ism_choose and ism_scatter, nothing is read back, and the mesh may have been moved on the GPU:

       glbk_ism_choose(gl, &choice, &maps, &map.texels, &seen, index);
       glbk_ism_scatter(gl, &spread, &maps, &seen, index);

   In shaders of your own

   These functions of lib/ism_light.glsl can be called after glbk_ism_bind:

       vec4 ism_light(vec3 p, vec3 n, vec3 ng, uint first, uint set_count);
       float ism_visible(uint v, ism_vpl l, vec3 p, vec3 ng, float bias);   // 1 lit, 0 not
       ism_vpl ism_read_vpl(uint v);                                        // l of ism_visible

   ism_light returns in rgb the irradiance of a point by VPLs first, first + set_count, ..., times set_count,
   in W/m^2 (0u and 1u: all VPLs), and in a the irradiance, mean of the channels, that ism_shading.near_mode
   took off. p is in world space; n and ng are unit, n for shading and ng the surface's own.

   How it works, and conventions

   ism.h chooses the VPLs (ism_choose), unless glbk_ism_choose does, and scatters surfels over the mesh
   (ism_scatter), unless glbk_ism_scatter does. From these lists the maps are drawn here and the pixels of a
   G-buffer are lit: surfels are drawn as discs with the depth test, pull and push fill the holes between
   them, and each pixel sums the light of its VPLs with visibility, interleaved with its neighbours and
   blurred afterwards. If ctx->compute is set, each of these steps is one dispatch in shared memory. A surfel
   is a triangle and barycentric coordinates in it, so geometry that moves needs nothing but new positions.

   Descs, settings and lists are the structs of ism.h with the same defaults, and results are those of ism.h
   up to the rounding of floats. One desc serves ism_create and glbk_ism_maps_create: lists of another one are
   GLBK_ERR_MISMATCH.

   A vector that is said to be unit may have a length of 0.97 to 1.03 and is used as it is, so interpolated
   normals must be normalised before they come; any other length in a list of VPLs is GLBK_ERR_INPUT.

   From the paper to the code

   The paper is that of ism.h: Ritschel et al., "Making Imperfect Shadow Maps View-Adaptive", 2011. A line has
   the function in GLSL, its twin in ism.h, and the rows of docs/conformance.md that test both.

     section 3.3  points drawn into maps         ism_place_surfel   ism__draw_points    T48 T50
     section 3.3  pull and push                  ism_pull           ism__pull           T49
     section 3.3  depths of texels in holes      ism_filled         ism__fill           T49
     section 3.2  importance by flux             ism_weight         ism__add_shares     T41
     section 4    importance by few receivers    ism_effect         ism__estimate_effect  T41
     section 4.2  receivers near the texel       ism_effect         ism__to_pixel       T41
     section 4    flux over N and probability    glbk_ism_choose    ism__make_vpl       T41
     section 4.1  prefix sums, VPL i at i / N    ism_search         ism__draw_vpl       T15 T16
     section 5.1  solid angle from one receiver  ism_solid_angle    ism__seen_by_view   T48
     section 5.2  solid angle from eight         ism_solid_angle    ism__seen_by_view   T48
     section 5.3  phases of surfels              glbk_ism_draw      ism_phase_surfels   T57
     section 5    surfels on triangles           ism_point          ism__points_of      T48
     section 6.1  maps of equal flux, of lobes   ism_map_direction  ism_map_direction   T46 T47
     section 6.2  subsets of VPLs                ism_light          ism__shade_pixel    -
     section 6.2  blur along surfaces            ism_smooth         ism__smooth_pixel   -
     section 6.4  dithered opacity               ism_dither         ism__dither         T58
     section 6.5  blur of the BRSM               ism_blurred        ism__blur_task      T41
     section 6.5  VPLs between texels            ism_inter_texel    ism__inter_texel    T55
     -            light close to a VPL           ism_patch_kernel   ism__patch_kernel   T42 T43 T44
     -            near points                    ism_gather         ism_near_points     T44
     -            how far they reach             ism_reach_of       ism__reach_of       -
     -            windows                        ism_zoom_axis      ism_zoom            -
     -            the next bounce                ism_cell_weight    ism_bounce          T45

   Configuration

     GL_ISM_IMPLEMENTATION   compiles the code, in one source file; the implementations of
                             gl_backend.h, gl_programs.h and gl_gbuffer.h may be compiled in another

   Layouts: docs/gpu-layouts.md.   The technique: docs/ism.md.   State: docs/gl-state.md.
   Licence: end of file. */
/* These includes stand outside the guard, since an implementation may be asked for when the file is included
   for the second time. ism.h lies above this folder; its implementation is not needed. */
#include "gl_programs.h"
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
