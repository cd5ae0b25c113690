/* gl_egl.c - GL contexts by EGL, without display and surface. */
#include "gl_internal.h"

#if DAPPLE_HAVE_EGL

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct egl_context {
    EGLDisplay display;
    EGLContext context;
} egl_context;

static int has_word(const char *list, const char *word)
{
    size_t length = strlen(word);
    for (; list && (list = strstr(list, word)) != NULL; list += length)
        if (list[length] == ' ' || list[length] == 0)
            return 1;
    return 0;
}

static EGLDisplay platform_display(EGLenum platform, void *native)
{
    PFNEGLGETPLATFORMDISPLAYEXTPROC get =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    EGLDisplay display = get ? get(platform, native, NULL) : EGL_NO_DISPLAY;
    return display != EGL_NO_DISPLAY && eglInitialize(display, NULL, NULL) ? display : EGL_NO_DISPLAY;
}

static EGLDisplay hardware_display(void)
{
    PFNEGLQUERYDEVICESEXTPROC query = (PFNEGLQUERYDEVICESEXTPROC)eglGetProcAddress("eglQueryDevicesEXT");
    PFNEGLQUERYDEVICESTRINGEXTPROC text =
        (PFNEGLQUERYDEVICESTRINGEXTPROC)eglGetProcAddress("eglQueryDeviceStringEXT");
    EGLDeviceEXT devices[16];
    EGLint count = 0;
    if (!query || !text || !query(16, devices, &count))
        return EGL_NO_DISPLAY;
    for (EGLint i = 0; i < count; i++) {
        EGLDisplay display;
        if (has_word(text(devices[i], EGL_EXTENSIONS), "EGL_MESA_device_software"))
            continue;
        display = platform_display(EGL_PLATFORM_DEVICE_EXT, devices[i]);
        if (display != EGL_NO_DISPLAY)
            return display;
    }
    return EGL_NO_DISPLAY;
}

static EGLContext create_context(EGLDisplay display, const ex_gl_options *o)
{
    const EGLint config_attributes[] = { EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                         o->es ? EGL_OPENGL_ES3_BIT : EGL_OPENGL_BIT, EGL_NONE };
    EGLint attributes[] = { EGL_CONTEXT_MAJOR_VERSION, o->major, EGL_CONTEXT_MINOR_VERSION, o->minor,
                            EGL_NONE, EGL_NONE, EGL_NONE, EGL_NONE, EGL_NONE };
    EGLConfig config = NULL;
    EGLint count = 0;
    int at = 4;
    if (!o->es) {
        attributes[at++] = EGL_CONTEXT_OPENGL_PROFILE_MASK;
        attributes[at++] = EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT;
    }
    if (o->debug) {
        attributes[at++] = EGL_CONTEXT_OPENGL_DEBUG;
        attributes[at++] = EGL_TRUE;
    }
    eglBindAPI(o->es ? EGL_OPENGL_ES_API : EGL_OPENGL_API);
    if (!eglChooseConfig(display, config_attributes, &config, 1, &count) || count < 1)
        config = NULL;      /* EGL_KHR_no_config_context */
    return eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
}

static int try_display(EGLDisplay display, const ex_gl_options *options, egl_context *out)
{
    if (display == EGL_NO_DISPLAY)
        return -1;
    out->display = display;
    out->context = create_context(display, options);
    if (out->context == EGL_NO_CONTEXT)
        return -1;
    if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, out->context))
        return 0;
    eglDestroyContext(display, out->context);
    return -1;
}

/* Displays are shared by all contexts of a process and are never terminated. */
static int create(void **self, const ex_gl_options *options, char *error)
{
    egl_context *c = calloc(1, sizeof *c);
    if (!c) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return -1;
    }
    if (try_display(hardware_display(), options, c) == 0 ||
        try_display(platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY), options, c) == 0) {
        *self = c;
        return 0;
    }
    snprintf(error, EX_ERROR_SIZE, "EGL gives no %s %d.%d context (error 0x%04x)", options->es ? "OpenGL ES" : "OpenGL",
             options->major, options->minor, (unsigned)eglGetError());
    free(c);
    return -1;
}

static void destroy(void *self)
{
    egl_context *c = self;
    eglMakeCurrent(c->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(c->display, c->context);
    free(c);
}

static int make_current(void *self, int on)
{
    egl_context *c = self;
    return eglMakeCurrent(c->display, EGL_NO_SURFACE, EGL_NO_SURFACE, on ? c->context : EGL_NO_CONTEXT) ? 0 : -1;
}

static glbk_proc_fn get_proc(const char *name) { return (glbk_proc_fn)eglGetProcAddress(name); }

const ex_gl_way ex_gl_way_egl = { create, destroy, make_current, get_proc };

#else
extern int ex_gl_no_egl;
int ex_gl_no_egl;
#endif
