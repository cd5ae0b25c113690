/* gl_wavelets.h - v0.9.0 - shadow fields of wavelets on OpenGL 3.3, ES 3.0, WebGL 2 - MIT-0 OR Unlicense

   What it does

   It lights a picture by fields of wavelets (SFIELD_BASIS_HAAR): shadows with edges, which the few bands of
   harmonics of gl_shadowfield.h blur. Entities, self-visibility, sky and G-buffer are the same for both.

   What it does not do

   - It needs gl_shadowfield.h beside it, which makes its tables and moves its entities; gl_gbuffer.h, which
     has what a camera sees; gl_programs.h, which makes programs; gl_backend.h, which makes the context
     object, textures and targets, and whose conventions, errors and rules about GL's state hold here; and
     shadowfield.h above it. The implementations of all of them belong into some file of the program.
   - No shader of yours can call it: its passes shade batches of points.
   - It has no resolve: light is a texture that your lighting pass multiplies by the surface's colour.

   Quick start

       #define SHADOWFIELD_IMPLEMENTATION
       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #define GL_SHADOWFIELD_IMPLEMENTATION
       #define GL_WAVELETS_IMPLEMENTATION
       #include "gl_backend/gl_wavelets.h"
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
           static const float corners[9] = { -1, 0, -1, 0, 0, 1, 1, 0, -1 };
           static float texels[3 * 6 * 16 * 16];            // of the sky: an overcast one
           glbk_context gl;
           glbk_sfield_scene scene;
           glbk_sfield_haar light;
           glbk_desc desc;
           glbk_sfield_haar_scene_desc fields;
           glbk_sfield_haar_desc sizes;
           glbk_result result;
           sfield_desc how;
           sfield_mesh mesh;
           sfield_field *field = NULL;
           const sfield_field *list[1];
           size_t i;

           memset(&desc, 0, sizeof desc);
           memset(&fields, 0, sizeof fields);
           memset(&sizes, 0, sizeof sizes);
           memset(&how, 0, sizeof how);
           memset(&mesh, 0, sizeof mesh);
           desc.get_proc_fn = get_proc;                     // a context is current
           result = glbk_init(&gl, &desc);
           if (result != GLBK_OK) {
               printf("no GL: %s\n", glbk_result_text(result));
               return result != GLBK_ERR_FUNCTION;
           }
           how.basis = SFIELD_BASIS_HAAR;
           how.cube_side = fields.cube_side = sizes.cube_side = 16;
           mesh.positions = corners;
           mesh.vertex_count = 3;
           if (sfield_build(&how, &mesh, &field, NULL) != SFIELD_OK) return 1;
           list[0] = field;
           fields.fields = list;
           fields.field_count = 1;
           fields.entity_capacity = 100;
           sizes.width = 640;
           sizes.height = 360;
           for (i = 0; i < sizeof texels / sizeof texels[0]; i++) texels[i] = 1;
           result = glbk_sfield_haar_upload(&gl, &fields, &scene);
           if (result == GLBK_OK) result = glbk_sfield_haar_create(&gl, &sizes, &light);
           if (result == GLBK_OK) result = glbk_sfield_haar_sky(&gl, &scene, texels);
           printf("%s\n", glbk_result_text(result));        // each frame: see below
           if (result == GLBK_OK) glbk_sfield_haar_free(&gl, &light);
           glbk_sfield_scene_free(&gl, &scene);
           sfield_free(field);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   A frame

       glbk_sfield_scene_entities(gl, &scene, entities, count);     // where all is, as for harmonics
       glbk_sfield_haar_sky(gl, &scene, texels);                    // sfield_scene_sky, if it has changed
       glbk_gbuffer_begin(gl, &gbuffer, world_to_clip, eye);        // or _import, or _upload
       glbk_gbuffer_object(gl, &gbuffer, &surface);                 // for each object, with your draw
       glbk_sfield_haar_shade(gl, &haar, &gbuffer, &scene, eye, 0); // haar.light: times albedo; gloss

   Conventions

   A batch of points is shaded at a time. Its passes list what each point meets from near to far, write
   the cubes of these lists, multiply texels, and add them up. Nothing is left out: a point that meets
   more than 16 takes further rounds. Products are on texels, as SFIELD_PRODUCT_TEXELS has them, so
   results are sfield_shade's but for roundings: docs/shadowfield.md has the bound. Where the context has
   compute shaders (4.3) and cubes at most 32 texels a side, a work group shades a point in one pass, as
   the CPU does: it adds lists of coefficients up and turns them into texels only where they hide. A point
   costs far more than one of harmonics: docs/measured/shadowfield.md.

   From the paper to the code

   The paper is that of shadowfield.h: Zhou, Hu, Lin, Guo and Shum, "Precomputed Shadow Fields for Dynamic
   Scenes", SIGGRAPH 2005. A line has the call, its twin in shadowfield.h, and the rows of docs/conformance.md
   that test both.

     section 3.1  S_d, the environment            glbk_sfield_haar_sky     sfield_scene_sky       -
     section 3.1  O_p, self-visibility            glbk_sfield_haar_self    sfield_build_self      -
     section 3.3  wavelets, cut                   glbk_sfield_haar_upload  sfield_query           wavelets
     section 4.1  the BRDF at the beginning       glbk_sfield_haar_shade   sfield_shade           gloss
     section 4.1  products of wavelets            glbk_sfield_haar_shade   sfield_haar_product    wavelets

   Configuration

     GL_WAVELETS_IMPLEMENTATION      in one source file: compiles the code; other files may have those of
                                     gl_backend.h, gl_programs.h, gl_gbuffer.h, gl_shadowfield.h and
                                     shadowfield.h

   Layouts: docs/gpu-layouts.md. The technique: docs/shadowfield.md, "Wavelets on OpenGL". State:
   docs/gl-state.md. Licence: end of file. */
/* This stands outside the guard, because a second inclusion of this file may ask for its implementation. */
#include "gl_shadowfield.h"

#ifndef GL_WAVELETS_H
#define GL_WAVELETS_H

#if GLBK_VERSION != 900
#error "gl_wavelets.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_WAVELETS_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_WAVELETS_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif
