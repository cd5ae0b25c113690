/* gl_web.c - the contexts of examples/common/gl_context.h in a browser: WebGL 2 by Emscripten, each on a canvas of its
   own. A context that is freed is lost at once, since browsers hold sixteen and take the oldest one away. */
#include "gl_context.h"

#include <emscripten.h>
#include <emscripten/html5.h>
#include <GLES3/gl3.h>
#include <stdio.h>
#include <stdlib.h>

struct ex_gl { EMSCRIPTEN_WEBGL_CONTEXT_HANDLE handle; };

static unsigned errors;     /* since the last ex_gl_create */

EM_JS(void, add_canvas, (int number), {
    var canvas = document.createElement('canvas');
    canvas.id = 'canvas' + number;
    canvas.width = canvas.height = 16;
    document.body.appendChild(canvas);
})

EM_JS(void, lose, (int handle), {
    var lost = GL.contexts[handle].GLctx.getExtension('WEBGL_lose_context');
    if (lost) lost.loseContext();
})

ex_gl *ex_gl_create(const ex_gl_options *options, char *error)
{
    static int count;
    EmscriptenWebGLContextAttributes attributes;
    char selector[20];
    ex_gl *gl = calloc(1, sizeof *gl);
    (void)options;
    errors = 0;
    if (!gl) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return NULL;
    }
    emscripten_webgl_init_context_attributes(&attributes);
    attributes.majorVersion = 2;
    add_canvas(++count);
    snprintf(selector, sizeof selector, "#canvas%d", count);
    gl->handle = emscripten_webgl_create_context(selector, &attributes);
    if (gl->handle > 0 && ex_gl_make_current(gl, 1) == 0)
        return gl;
    snprintf(error, EX_ERROR_SIZE, "no WebGL 2 context: error %d", (int)gl->handle);
    free(gl);
    return NULL;
}

ex_gl *ex_gl_create_window(const ex_gl_options *options, char *error)
{
    return ex_gl_create(options, error);
}

void ex_gl_free(ex_gl *gl)
{
    if (!gl)
        return;
    lose(gl->handle);
    emscripten_webgl_destroy_context(gl->handle);
    free(gl);
}

int ex_gl_make_current(ex_gl *gl, int on)
{
    return emscripten_webgl_make_context_current(on ? gl->handle : 0) == EMSCRIPTEN_RESULT_SUCCESS ? 0 : -1;
}

glbk_proc_fn ex_gl_get_proc(const char *name, void *gl)
{
    (void)gl;
    return (glbk_proc_fn)emscripten_webgl_get_proc_address(name);
}

void *ex_gl_window(ex_gl *gl)
{
    (void)gl;
    return NULL;
}

/* A browser has no messages for programs: what glGetError says at this moment counts. Of the current context. */
unsigned ex_gl_errors(const ex_gl *gl, const char **last)
{
    (void)gl;
    while (glGetError() != GL_NO_ERROR) errors++;
    if (last)
        *last = "in the browser's console";
    return errors;
}
