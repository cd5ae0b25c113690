/* gl_gbuffer.h - v0.9.0 - one G-buffer for all techniques, OpenGL 3.3, ES 3.0, WebGL 2 - MIT-0 OR Unlicense

   What it does

   A G-buffer holds what a camera sees in each pixel: the place, the normals, the material and the entity.
   gl_csm.h, gl_shadowfield.h, gl_wavelets.h, gl_envshadow.h, gl_rsm.h and gl_ism.h light it. It is filled
   in one of three ways: it is drawn from your vertex arrays, whatever the locations of their attributes;
   it is uploaded from the CPU; or one pass makes it from textures that your renderer has anyway
   (glbk_gbuffer_import): depth or places, normals in four packings, colours, gloss, entities. Shaders of
   your own read it by glbk_read_point() of lib/gbuffer.glsl.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, textures and targets, and whose
     conventions, errors and rules about GL's state hold here; and gl_programs.h, which makes programs.
     Materials are those of lightsampling.h, whose implementation is not needed.
   - It holds one sample and one surface a pixel: there is no transparency and no multisampling.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #include "gl_backend/gl_gbuffer.h"
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
           glbk_context gl;
           glbk_gbuffer seen;
           glbk_desc desc;
           glbk_gbuffer_desc sizes;
           glbk_import mine;
           glbk_texture depth, normals;
           glbk_result result;
           int i;

           memset(&desc, 0, sizeof desc);
           memset(&sizes, 0, sizeof sizes);
           memset(&mine, 0, sizeof mine);
           memset(&depth, 0, sizeof depth);
           memset(&normals, 0, sizeof normals);
           desc.get_proc_fn = get_proc;                     // a context is current
           result = glbk_init(&gl, &desc);
           if (result != GLBK_OK) {
               printf("no GL: %s\n", glbk_result_text(result));
               return result != GLBK_ERR_FUNCTION;
           }
           sizes.width = depth.width = normals.width = 640;
           sizes.height = depth.height = normals.height = 360;
           result = glbk_gbuffer_create(&gl, &sizes, &seen);
           depth.name = 1;                                  // of your renderer: what glGenTextures gave it
           normals.name = 2;
           mine.depth = &depth;                             // with the matrix by which it was drawn
           mine.normals = &normals;
           mine.normal_packing = GLBK_NORMAL_PACKING_UNIT;  // RGBA8: 0..1 for -1..1
           for (i = 0; i < 4; i++) mine.world_to_clip[5 * i] = 1;
           for (i = 0; i < 3; i++) mine.material.diffuse[i] = 0.5f;
           if (result == GLBK_OK) result = glbk_gbuffer_import(&gl, &seen, &mine);
           printf("%s\n", glbk_result_text(result));
           glbk_gbuffer_free(&gl, &seen);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   Vectors

   A vector that is said to be unit may have a length of 0.97 to 1.03 and is used as it is, and any other
   length is an error; vectors that are drawn or imported are normalised by the shaders.

   Configuration

     GL_GBUFFER_IMPLEMENTATION   in one source file: compiles the code; another file may have those of
                                 gl_backend.h and gl_programs.h

   Layouts: docs/gpu-layouts.md. How to bring your own: docs/gbuffer.md. State: docs/gl-state.md.
   Licence: end of file. */
/* These stand outside the guard, because a second inclusion of this file may ask for their implementations.
   lightsampling.h lies above this folder. */
#include "gl_programs.h"
#include "../lightsampling.h"

#ifndef GL_GBUFFER_H
#define GL_GBUFFER_H

#if GLBK_VERSION != 900
#error "gl_gbuffer.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_GBUFFER_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_GBUFFER_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif
