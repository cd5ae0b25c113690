/* gl_window.c - GL contexts with a window, by GLFW. */
#include "gl_internal.h"

#include <stdio.h>

#if DAPPLE_HAVE_GLFW

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

static int create(void **self, const ex_gl_options *o, char *error)
{
    const char *reason = "unknown";
    GLFWwindow *window = NULL;
    if (glfwInit()) {
        glfwDefaultWindowHints();
        glfwWindowHint(GLFW_CLIENT_API, o->es ? GLFW_OPENGL_ES_API : GLFW_OPENGL_API);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, o->major);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, o->minor);
        if (!o->es)
            glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
#ifdef __APPLE__
        glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, 1);      /* there is no other */
        glfwWindowHint(GLFW_COCOA_RETINA_FRAMEBUFFER, 0);   /* width x height pixels */
#endif
        glfwWindowHint(GLFW_CONTEXT_CREATION_API, o->use_egl ? GLFW_EGL_CONTEXT_API : GLFW_NATIVE_CONTEXT_API);
        glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, o->debug);
        glfwWindowHint(GLFW_VISIBLE, !o->hidden);
        window = glfwCreateWindow(o->width > 0 ? o->width : 64, o->height > 0 ? o->height : 64,
                                  o->title ? o->title : "dapple", NULL, NULL);
    }
    if (!window) {
        glfwGetError(&reason);
        snprintf(error, EX_ERROR_SIZE, "GLFW opens no window: %s", reason ? reason : "unknown");
        return -1;
    }
    glfwMakeContextCurrent(window);
    *self = window;
    return 0;
}

static void destroy(void *self) { glfwDestroyWindow(self); }

static int make_current(void *self, int on)
{
    glfwMakeContextCurrent(on ? self : NULL);
    return 0;
}

static glbk_proc_fn get_proc(const char *name) { return (glbk_proc_fn)glfwGetProcAddress(name); }

static const ex_gl_way way = { create, destroy, make_current, get_proc };

ex_gl *ex_gl_create_window(const ex_gl_options *options, char *error)
{
    return ex_gl_create_by(&way, options, error);
}

void *ex_gl_window(ex_gl *gl) { return ex_gl_self(gl); }

#else

ex_gl *ex_gl_create_window(const ex_gl_options *options, char *error)
{
    (void)options;
    snprintf(error, EX_ERROR_SIZE, "this build has no GLFW");
    return NULL;
}

void *ex_gl_window(ex_gl *gl) { return (void)gl, NULL; }

#endif
