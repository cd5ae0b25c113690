/* gl_context.h - GL contexts for the example programs and tests: headless by EGL or OSMesa, windows by GLFW. No GL
   function is called by its link-time name, so that the three may be used side by side. */
#ifndef EX_GL_CONTEXT_H
#define EX_GL_CONTEXT_H

#include "../../gl_backend/gl_programs.h"
#include "scene.h"

typedef enum ex_gl_api {
    EX_GL_HEADLESS,              /* EGL, and OSMesa where that fails */
    EX_GL_EGL,                   /* without a surface; a hardware device where there is one, else Mesa's surfaceless */
    EX_GL_OSMESA
} ex_gl_api;

typedef struct ex_gl_options {
    ex_gl_api   api;             /* of ex_gl_create */
    int         es;              /* OpenGL ES, else core profile */
    int         major, minor;    /* 0, 0: 4.3 or, where that fails, 3.3; 3.0 with es */
    int         debug;           /* counts the driver's messages of type error */
    int         width, height;   /* of ex_gl_create_window */
    int         hidden;          /* the window is not shown */
    int         use_egl;         /* the window's context comes from EGL */
    const char *title;
} ex_gl_options;

typedef struct ex_gl ex_gl;

/* Make a context and make it current; NULL and one line in error (EX_ERROR_SIZE) on failure. */
ex_gl    *ex_gl_create(const ex_gl_options *options, char *error);
ex_gl    *ex_gl_create_window(const ex_gl_options *options, char *error);       /* by GLFW */
void      ex_gl_free(ex_gl *gl);                               /* accepts NULL */
int       ex_gl_make_current(ex_gl *gl, int on);               /* off: no context is current; 0, or -1 */
glbk_proc_fn ex_gl_get_proc(const char *name, void *gl);          /* for glbk_desc: get_proc_fn, and gl as its user */
void      ex_gl_log(void *user, const char *message);          /* for glbk_desc: system.log, to stderr */
void     *ex_gl_window(ex_gl *gl);                             /* GLFWwindow of ex_gl_create_window */
unsigned  ex_gl_errors(const ex_gl *gl, const char **last);    /* messages of type error since ex_gl_create */

/* With DAPPLE_GL_DEBUG=1 in the environment every context is a debug context, and a program in which one of them saw a
   message of type error, or had a GL error pending at its end, says "GL error" on stderr and does not end with 0. */

#endif
