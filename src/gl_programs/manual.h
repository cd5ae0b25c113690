/* gl_programs.h - v0.9.0 - programs with the GLSL of gl_*.h, OpenGL 3.3, ES 3.0, WebGL 2 - MIT-0 OR Unlicense

   What it does

   gl_csm.h, gl_shadowfield.h, gl_envshadow.h, gl_rsm.h and gl_ism.h keep their GLSL in themselves. This
   header makes programs of it: from your text and the functions that the text calls it assembles what a
   driver compiles, compiles and links that, and gives textures and uniform blocks their slots. For a renderer
   that compiles its shaders itself it writes the text alone. All headers above include it.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, textures, targets and passes, and whose
     conventions, errors and rules about GL's state hold here.
   - It is of no use without a technique. A program that needs gl_backend.h only, with shaders that it links
     itself, leaves this header out and makes its program the one in use after glbk_begin, or gives glbk_begin
     a glbk_program that holds GL's name alone.
   - It has no cache of programs and no include directives: your text names the functions that it uses.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
       #include "gl_backend/gl_programs.h"
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
           static const char fragment[] =
               "out vec4 color;\n"
               "void main() { color = vec4(gl_FragCoord.xy / 512.0, 0.5, 1.0); }\n";
           glbk_context gl;
           glbk_program program;
           glbk_desc desc;
           glbk_source source;
           glbk_pass pass;
           glbk_result result;

           memset(&desc, 0, sizeof desc);
           desc.get_proc_fn = get_proc;                     // a context is current
           result = glbk_init(&gl, &desc);
           if (result != GLBK_OK) {
               printf("no GL: %s\n", glbk_result_text(result));
               return result != GLBK_ERR_FUNCTION;
           }
           memset(&source, 0, sizeof source);
           source.fragment = fragment;                      // parts and uses: those of a technique
           result = glbk_program_compile(&gl, &source, &program);
           memset(&pass, 0, sizeof pass);
           pass.viewport[2] = pass.viewport[3] = 512;       // of the framebuffer that is bound
           if (result == GLBK_OK) result = glbk_begin(&gl, &pass, &program);
           if (result == GLBK_OK) glbk_draw_screen(&gl);
           printf("%s\n", glbk_result_text(result));
           glbk_program_free(&gl, &program);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   With functions of a technique: examples/06_csm_gl_minimal.c (07 to 10 for the others). With functions of
   two techniques in one shader: examples/11_sky_bounce_gl_minimal.c. In a program that the renderer links
   itself: examples/13_deferred_gl.c.

   Conventions

     file       a piece of GLSL in a header: a library file (functions) or a program's main
     part       all files of one header, and the slots of what they declare
     base       the part of this header
     set        defines that a program is compiled with: "FILTER=1 COUNT=4"
     slot       number of a texture unit, uniform block, storage buffer or image as the lists of bindings give
                it; the context adds desc.first_unit to those of textures and desc.first_block to those of
                uniform blocks
     table      an array of texels, addressed by one number: a 2D array texture 1024 wide and 1024 high

   How it works

   GLSL is kept without its comments, a text for each file under src/gl_programs and src/gl_*. A program is
   version line, defines, lib/prelude.glsl, the library files that it names, and its own. One text serves 330
   core and 300 es. Names, units and block layouts come from one list for each header that C, GLSL and the
   tests share.

   Floats on ES 3.0 and WebGL 2 are renderable with EXT_color_buffer_float only. Without it a target of format
   GLBK_FORMAT_COLOR holds the bits of floats in integers, and lib/prelude.glsl hides the difference
   (glbk_color).

   Configuration

     GL_PROGRAMS_IMPLEMENTATION   in one source file: compiles the code; another file may have gl_backend.h's

   Memory comes from the allocator of the context's desc, only while a program is compiled.
   Layouts: docs/gpu-layouts.md.  State: docs/gl-state.md.  Licence: end of file. */
/* This include stands outside the guard, because a second inclusion of this file may ask for its
   implementation. */
#include "gl_backend.h"

#ifndef GL_PROGRAMS_H
#define GL_PROGRAMS_H

#if GLBK_VERSION != 900
#error "gl_programs.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_PROGRAMS_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_PROGRAMS_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif
