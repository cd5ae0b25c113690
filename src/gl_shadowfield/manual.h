/* gl_shadowfield.h - v0.9.0 - shadow fields on OpenGL 3.3, ES 3.0, WebGL 2 - MIT-0 OR Unlicense

   What it does

   It brings fields of shadowfield.h onto the GPU: shaders of your own call sfield_shade(), a complete pass
   shades a G-buffer, and cubes of new fields are drawn and projected by the GPU.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, textures and targets, and whose
     conventions, errors and rules about GL's state hold here; gl_programs.h, which makes programs;
     gl_gbuffer.h, which has what a camera sees; and shadowfield.h above it, whose fields and entities it
     takes and whose functions it calls. The implementations of all of them belong into some file of the
     program.
   - Fields of wavelets are lit by gl_wavelets.h, which stands above this header: scenes here have harmonics.
   - It has no resolve: light is a texture that your lighting pass multiplies by the surface's colour.

   Quick start

       #define SHADOWFIELD_IMPLEMENTATION
       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
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

   A frame

       glbk_sfield_scene_entities(gl, &scene, entities, count);     // or _scene_sky: where all is
       glbk_gbuffer_begin(gl, &gbuffer, world_to_clip, eye);        // or _import, or _upload
       glbk_gbuffer_object(gl, &gbuffer, &surface);                 // for each object, with your draw
       glbk_sfield_shade(gl, &renderer, &gbuffer, &scene, eye, 0);

   renderer.light then holds the light at each pixel without the surface's colour. No function resolves the
   light to a picture, as those of other techniques do, since how light meets colour is your lighting pass's
   matter: albedo times light.rgb, and specular colour times gloss.rgb. With desc.materials metal-rough pixels
   send base (1 - metallic) light.rgb + gloss.rgb to the eye.

   In shaders of your own

   Two functions of lib/sfield_shade.glsl can be called after glbk_sfield_bind, with SFIELD_BANDS defined:

       void sfield_cosine(vec3 n, out float t[SFIELD_COEFS]);
       sfield_sums sfield_shade(vec3 position, vec3 normal, uint own, float t[SFIELD_COEFS],
                                float g[SFIELD_COEFS]);

       position, normal   world space; the normal is unit
       own                the entity that the point lies on, counted from 1; 0 = none
       t                  from sfield_cosine, or self-visibility x cosine, turned into the world
       g                  t times Phong's lobe, which is read if SFIELD_GLOSS is defined as 1 or 2

   With SFIELD_GLOSS=2 a third function of direction, h, follows g, and the result's grazing is of h: so the
   three kernels of the metal-rough BRDF find their light in one call (lib/sfield_point.glsl). sfield_kernel
   of lib/sfield_brdf.glsl makes them from the scene's table of BRDFs.

   The result has light, which times albedo is radiance, as in renderer.light and sfield_points.rgb; gloss;
   and open, the share of the cosine-weighted sky that nothing hides.

   Conventions

   The fields of a scene are uploaded once, into one table, with the terms of the product; entities and the
   sky stand in another one, so that moving them leaves the fields alone. Fields, entities and self-visibility
   are shadowfield.h's, and so are the numbers of entities: they count from 1, 0 is none. The points that are
   shaded are the pixels of a G-buffer (gl_gbuffer.h): of the screen, or vertices.

   A vector that is said to be unit may have a length of 0.97 to 1.03 and is used as it is, so interpolated
   normals must be normalised before they come.

   From the paper to the code

   The paper is that of shadowfield.h: Zhou, Hu, Lin, Guo and Shum, "Precomputed Shadow Fields for Dynamic
   Scenes", SIGGRAPH 2005. A line has the function in GLSL or the call, its twin in shadowfield.h, and the
   rows of docs/conformance.md that test both.

     section 3.1  an object occlusion field       glbk_sfield_builder_see  sfield_build           T72
     section 3.1  a source radiance field         glbk_sfield_builder_see  sfield_build_emissive  T73
     section 3.1  S_d, the environment            sfield_sky               sfield_scene_sky       -
     section 3.1  O_p, self-visibility            glbk_sfield_self_object   sfield_build_self      -
     section 3.3  eight samples of shells         sfield_locate            sfield_query           T74 T75
     section 3.3  16 coefficients of 8 bits       sfield_fetch             sfield_query           T74
     section 4    B, the rendering equation       glbk_sfield_shade        sfield_shade           T73
     section 4.1  triple products                 sfield_product           sfield_sh_product      T5 T6
     section 4.1  the double product              sfield_dot               sfield_sh_dot          -
     section 4.1  the BRDF at the beginning       sfield_kernel            sfield_sh_brdf         -
     section 4.1  rotations                       sfield_rotate            sfield_sh_rotate       T9 T76
     section 4.1  the basis, the cosine           sfield_basis             sfield_sh_basis        T3 T10
     figure 5     entities from near to far       sfield_shade             sfield_shade           T78
     section 4.2  culling                         sfield_occlusion         sfield_scene_stats     -

   Configuration

     GL_SHADOWFIELD_IMPLEMENTATION   in one source file: compiles the code; other files may have those of
                                     gl_backend.h, gl_programs.h, gl_gbuffer.h and shadowfield.h

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
