/* gl_osmesa.c - GL contexts by OSMesa, which renders into memory. */
#include "gl_internal.h"

#if DAPPLE_HAVE_OSMESA

/* GL/osmesa.h brings GL's own declarations along; nothing of them is called. */
#include <GL/osmesa.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 16 };     /* of the default framebuffer, which nobody looks at */

typedef struct osmesa_context {
    OSMesaContext context;
    unsigned char pixels[4 * SIDE * SIDE];
} osmesa_context;

static int make_current(void *self, int on)
{
    osmesa_context *c = self;
    return OSMesaMakeCurrent(on ? c->context : NULL, on ? c->pixels : NULL, GL_UNSIGNED_BYTE, SIDE, SIDE) || !on ? 0
                                                                                                                 : -1;
}

static void destroy(void *self)
{
    osmesa_context *c = self;
    if (c->context)
        OSMesaDestroyContext(c->context);
    free(c);
}

static int create(void **self, const ex_gl_options *o, char *error)
{
    const int attributes[] = { OSMESA_FORMAT, OSMESA_RGBA, OSMESA_DEPTH_BITS, 24, OSMESA_PROFILE, OSMESA_CORE_PROFILE,
                               OSMESA_CONTEXT_MAJOR_VERSION, o->major, OSMESA_CONTEXT_MINOR_VERSION, o->minor, 0 };
    osmesa_context *c = calloc(1, sizeof *c);
    if (!c) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return -1;
    }
    c->context = o->es ? NULL : OSMesaCreateContextAttribs(attributes, NULL);
    if (!c->context || make_current(c, 1) != 0) {
        snprintf(error, EX_ERROR_SIZE, "OSMesa gives no %s %d.%d context", o->es ? "OpenGL ES" : "OpenGL", o->major,
                 o->minor);
        destroy(c);
        return -1;
    }
    *self = c;
    return 0;
}

static glbk_proc_fn get_proc(const char *name) { return (glbk_proc_fn)OSMesaGetProcAddress(name); }

const ex_gl_way ex_gl_way_osmesa = { create, destroy, make_current, get_proc };

#else
extern int ex_gl_no_osmesa;
int ex_gl_no_osmesa;
#endif
