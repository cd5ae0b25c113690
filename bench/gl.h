/* gl.h - the context that benchmarks on OpenGL run in. Include bench.h before. */
#ifndef BENCH_GL_H
#define BENCH_GL_H

#include "gl_timer.h"

typedef struct bn_gl { ex_gl *context; glbk_context gl; ex_gl_timer timer; } bn_gl;  /* zeroed = none */

int  bn_gl_open(bn_gl *g, int core_only);       /* 0, or the line is said */
void bn_gl_close(bn_gl *g);
int  bn_gl_failed(glbk_result result);

#endif
