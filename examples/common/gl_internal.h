/* gl_internal.h - what the ways to a GL context have in common. */
#ifndef EX_GL_INTERNAL_H
#define EX_GL_INTERNAL_H

#include "gl_context.h"

/* One way to a context. create gets a complete version and puts its state into *self. */
typedef struct ex_gl_way {
    int       (*create)(void **self, const ex_gl_options *options, char *error);    /* 0, or -1 */
    void      (*destroy)(void *self);
    int       (*make_current)(void *self, int on);
    glbk_proc_fn (*get_proc)(const char *name);
} ex_gl_way;

extern const ex_gl_way ex_gl_way_egl, ex_gl_way_osmesa;

ex_gl *ex_gl_create_by(const ex_gl_way *way, const ex_gl_options *options, char *error);
void  *ex_gl_self(ex_gl *gl);
void   ex_gl_note(ex_gl *gl, const char *text);     /* an error of this context */

/* proc, or where it draws a function that first looks for errors that drivers let pass. */
glbk_proc_fn ex_gl_watch(const char *name, glbk_proc_fn proc, glbk_proc_fn (*get)(const char *));
void      ex_gl_watch_current(ex_gl *gl);           /* whose calls are seen from here on */
void      ex_gl_watch_forget(const ex_gl *gl);      /* before it is freed */

#endif
