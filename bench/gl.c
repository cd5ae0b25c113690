/* gl.c - see gl.h. */
#include "bench.h"
#include "gl.h"

#include <string.h>

int bn_gl_open(bn_gl *g, int core_only)
{
    ex_gl_options options = { EX_GL_HEADLESS, 0, 0, 0, 0, 0, 0, 0, 0, NULL };
    char error[EX_ERROR_SIZE];
    glbk_desc desc;
    glbk_result result;
    memset(g, 0, sizeof *g);
    memset(&desc, 0, sizeof desc);
    g->context = ex_gl_create(&options, error);
    if (!g->context)
        return bn_failed("OpenGL", error);
    desc.get_proc_fn = ex_gl_get_proc;
    desc.user = g->context;
    desc.system.log = ex_gl_log;
    desc.core_only = core_only;
    result = glbk_init(&g->gl, &desc);
    if (result == GLBK_OK) {
        ex_gl_timer_open(&g->timer, &g->gl, ex_gl_get_proc, g->context);
        return 0;
    }
    ex_gl_free(g->context);
    g->context = NULL;
    return bn_failed("OpenGL", glbk_result_text(result));
}

void bn_gl_close(bn_gl *g)
{
    if (g->context)
        ex_gl_timer_close(&g->timer);
    glbk_free(&g->gl);
    ex_gl_free(g->context);
    memset(g, 0, sizeof *g);
}

int bn_gl_goes_on(const glbk_context *gl, int run, int least, double *since)
{
    if (run <= 1)
        *since = ex_seconds();
    return run < least || (!ex_gl_is_software(gl->renderer) && ex_seconds() - *since < 2);
}

int bn_gl_failed(glbk_result result) { return bn_failed("OpenGL", glbk_result_text(result)); }
