/* gl_timer.c - see gl_timer.h. */
#define _POSIX_C_SOURCE 200809L
#include "gl_timer.h"

#include "common.h"

#include <string.h>

enum { TIME_ELAPSED = 0x88BF, QUERY_RESULT = 0x8866 };

int ex_gl_is_software(const char *renderer)
{
    static const char *const names[] = { "llvmpipe", "softpipe", "swrast", "SwiftShader", "Software Rasterizer",
                                         "Microsoft Basic Render", "Apple Software" };
    for (size_t i = 0; renderer && i < sizeof names / sizeof names[0]; i++)
        if (strstr(renderer, names[i]))
            return 1;
    return 0;
}

/* The five functions of queries, which gl_backend.h does without; 0: one is missing. */
static int load(ex_gl_timer *t, glbk_get_proc_fn get_proc, void *user)
{
    static const char *const names[5] = { "glGenQueries", "glDeleteQueries", "glBeginQuery", "glEndQuery",
                                          "glGetQueryObjectui64v" };
    glbk_proc_fn procs[5];
    for (int i = 0; i < 5; i++)
        if (!(procs[i] = get_proc(names[i], user)))
            return 0;
    memcpy(&t->gen, &procs[0], sizeof t->gen);
    memcpy(&t->destroy, &procs[1], sizeof t->destroy);
    memcpy(&t->begin, &procs[2], sizeof t->begin);
    memcpy(&t->end, &procs[3], sizeof t->end);
    memcpy(&t->get, &procs[4], sizeof t->get);
    return 1;
}

void ex_gl_timer_open(ex_gl_timer *t, const glbk_context *gl, glbk_get_proc_fn get_proc, void *user)
{
    memset(t, 0, sizeof *t);
    t->gl = gl;
    t->by_query = !gl->es && !ex_gl_is_software(gl->renderer) && load(t, get_proc, user);
    if (t->by_query)
        t->gen(1, &t->name);
}

void ex_gl_timer_start(ex_gl_timer *t)
{
    if (t->by_query)
        t->begin(TIME_ELAPSED, t->name);
    else {
        t->gl->gl.Finish();
        t->started = ex_seconds();
    }
}

double ex_gl_timer_stop(ex_gl_timer *t)
{
    uint64_t nanoseconds = 0;
    if (!t->by_query) {
        t->gl->gl.Finish();
        return ex_seconds() - t->started;
    }
    t->end(TIME_ELAPSED);
    t->get(t->name, QUERY_RESULT, &nanoseconds);
    return 1e-9 * (double)nanoseconds;
}

void ex_gl_timer_close(ex_gl_timer *t)
{
    if (t->by_query)
        t->destroy(1, &t->name);
    memset(t, 0, sizeof *t);
}
