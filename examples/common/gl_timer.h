/* gl_timer.h - how long GL takes: by a timer query where a GPU answers it, else wall time round glFinish: queries of
   software drivers are wrong, and ES 3.0 has none. */
#ifndef EX_GL_TIMER_H
#define EX_GL_TIMER_H

#include "gl_context.h"

typedef struct ex_gl_timer {
    const glbk_context *gl;
    int      by_query;              /* else by glFinish */
    uint32_t name;
    double   started;
    void (GLBK_CALL *gen)(int32_t count, uint32_t *names);
    void (GLBK_CALL *destroy)(int32_t count, const uint32_t *names);
    void (GLBK_CALL *begin)(uint32_t target, uint32_t name);
    void (GLBK_CALL *end)(uint32_t target);
    void (GLBK_CALL *get)(uint32_t name, uint32_t what, uint64_t *out);
} ex_gl_timer;

int    ex_gl_is_software(const char *renderer);         /* by GL's name of it, as in glbk_context */
void   ex_gl_timer_open(ex_gl_timer *timer, const glbk_context *gl, glbk_get_proc_fn get_proc, void *user);
void   ex_gl_timer_start(ex_gl_timer *timer);
double ex_gl_timer_stop(ex_gl_timer *timer);            /* seconds since the start; waits for the GPU */
void   ex_gl_timer_close(ex_gl_timer *timer);           /* while its context is current */

#endif
