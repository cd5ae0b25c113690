/* gl.h - the context that benchmarks on OpenGL run in. Include bench.h before. */
#ifndef BENCH_GL_H
#define BENCH_GL_H

#include "gl_timer.h"

typedef struct bn_gl { ex_gl *context; glbk_context gl; ex_gl_timer timer; } bn_gl;  /* zeroed = none */

int  bn_gl_open(bn_gl *g, int core_only);       /* 0, or the line is said */
void bn_gl_close(bn_gl *g);
int  bn_gl_failed(glbk_result result);

/* Whether a loop that measures goes on after `run` runs: until it had `least`, and on a GPU for two seconds after the
   first run, which compiles: one that stood idle takes a second of work to raise its clock. *since is its own. */
int  bn_gl_goes_on(const glbk_context *gl, int run, int least, double *since);

#endif
