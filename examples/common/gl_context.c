/* gl_context.c - GL contexts, whichever way they come. */
#include "gl_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct ex_gl {
    const ex_gl_way *way;
    void            *self;
    unsigned         errors;
    char             last[300];
    int              watched;
};

/* ---- DAPPLE_GL_DEBUG=1: errors of all contexts of this process, said at its end ---- */

static struct { unsigned errors; int registered; char last[300]; } watched;

static void say_errors(void)
{
    if (!watched.errors)
        return;
    fprintf(stderr, "GL error: %u, the last: %s\n", watched.errors, watched.last);
    fflush(NULL);
    _Exit(EXIT_FAILURE);
}

static int is_watched(void)
{
    const char *value = getenv("DAPPLE_GL_DEBUG");
    if (!value || strcmp(value, "1") != 0)
        return 0;
    if (!watched.registered)
        watched.registered = atexit(say_errors) == 0;
    return 1;
}

static void note_error(const char *text)
{
    watched.errors++;
    snprintf(watched.last, sizeof watched.last, "%s", text);
}

void ex_gl_note(ex_gl *gl, const char *text)
{
    gl->errors++;
    note_error(text);
    snprintf(gl->last, sizeof gl->last, "%s", text);
}

/* ---- the driver's messages: OpenGL 4.3, ES 3.2 or KHR_debug ---- */

typedef void(GLBK_CALL *debug_proc)(uint32_t source, uint32_t type, uint32_t id, uint32_t severity, int32_t length,
                                    const char *text, const void *user);

static void GLBK_CALL on_message(uint32_t source, uint32_t type, uint32_t id, uint32_t severity, int32_t length,
                                 const char *text, const void *user)
{
    /* GL hands the pointer back as const; it is our own object. */
    union { const void *in; ex_gl *out; } owner;
    (void)source, (void)id, (void)severity, (void)length;
    owner.in = user;
    if (type != 0x824C /* DEBUG_TYPE_ERROR */)
        return;
    ex_gl_note(owner.out, text);
}

static void listen(ex_gl *gl)
{
    void(GLBK_CALL *callback)(debug_proc, const void *);
    void(GLBK_CALL *enable)(uint32_t);
    const uint8_t *(GLBK_CALL *get_string)(uint32_t);
    glbk_proc_fn proc = gl->way->get_proc("glGetString");
    const char *version;
    if (!proc)
        return;
    memcpy(&get_string, &proc, sizeof proc);
    version = (const char *)get_string(0x1F02 /* VERSION */);
    proc = gl->way->get_proc(version && strstr(version, "OpenGL ES") ? "glDebugMessageCallbackKHR"
                                                                     : "glDebugMessageCallback");
    if (!proc)
        return;
    memcpy(&callback, &proc, sizeof proc);
    proc = gl->way->get_proc("glEnable");
    memcpy(&enable, &proc, sizeof proc);
    enable(0x92E0 /* DEBUG_OUTPUT */);
    enable(0x8242 /* DEBUG_OUTPUT_SYNCHRONOUS */);
    callback(on_message, gl);
}

unsigned ex_gl_errors(const ex_gl *gl, const char **last)
{
    if (last)
        *last = gl->last;
    return gl->errors;
}

/* ---- creation ---- */

/* With and, since some drivers have no such contexts, without the debug flag; most speak either way. */
static int create_flags(ex_gl *gl, const ex_gl_options *options, int major, int minor, char *error)
{
    ex_gl_options o = *options;
    o.major = major;
    o.minor = minor;
    if (gl->way->create(&gl->self, &o, error) == 0)
        return 0;
    if (!o.debug)
        return -1;
    o.debug = 0;
    return gl->way->create(&gl->self, &o, error);
}

static int create_version(ex_gl *gl, const ex_gl_options *o, char *error)
{
    if (o->major || o->es)
        return create_flags(gl, o, o->major ? o->major : 3, o->minor, error);
    if (create_flags(gl, o, 4, 3, error) == 0)
        return 0;
    return create_flags(gl, o, 3, 3, error);
}

static int create_any(ex_gl *gl, const ex_gl_options *options, char *error)
{
    static const struct { ex_gl_api api; const ex_gl_way *way; const char *name; } ways[] = {
#if DAPPLE_HAVE_EGL
        { EX_GL_EGL, &ex_gl_way_egl, "EGL" },
#endif
#if DAPPLE_HAVE_OSMESA
        { EX_GL_OSMESA, &ex_gl_way_osmesa, "OSMesa" },
#endif
        { EX_GL_HEADLESS, NULL, NULL }
    };
    snprintf(error, EX_ERROR_SIZE, "no GL context: this build has neither EGL nor OSMesa");
    for (size_t i = 0; ways[i].way; i++) {
        if (options->api != EX_GL_HEADLESS && options->api != ways[i].api)
            continue;
        gl->way = ways[i].way;
        if (create_version(gl, options, error) == 0)
            return 0;
    }
    return -1;
}

/* With a way of the caller's, so that windows are linked only into programs that open them. */
ex_gl *ex_gl_create_by(const ex_gl_way *way, const ex_gl_options *options, char *error)
{
    ex_gl *gl = calloc(1, sizeof *gl);
    ex_gl_options wanted = *options;
    wanted.debug |= is_watched();
    if (!gl) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return NULL;
    }
    gl->way = way;
    if (way ? create_version(gl, &wanted, error) != 0 : create_any(gl, &wanted, error) != 0) {
        free(gl);
        return NULL;
    }
    gl->watched = wanted.debug;
    ex_gl_watch_current(gl);
    if (wanted.debug)
        listen(gl);
    return gl;
}

ex_gl *ex_gl_create(const ex_gl_options *options, char *error)
{
    return ex_gl_create_by(NULL, options, error);
}

/* What glGetError still has to say, of drivers without messages too; of another context if that is current. */
static void note_pending(ex_gl *gl)
{
    uint32_t(GLBK_CALL *get_error)(void);
    glbk_proc_fn proc = gl->way->get_proc("glGetError");
    if (!proc)
        return;
    memcpy(&get_error, &proc, sizeof proc);
    for (int i = 0; i < 10; i++) {
        char text[40];
        uint32_t code = get_error();
        if (!code)
            return;
        snprintf(text, sizeof text, "glGetError 0x%04x", (unsigned)code);
        note_error(text);
    }
}

void ex_gl_free(ex_gl *gl)
{
    if (!gl)
        return;
    if (is_watched())
        note_pending(gl);
    gl->way->destroy(gl->self);
    ex_gl_watch_forget(gl);
    free(gl);
}

int ex_gl_make_current(ex_gl *gl, int on)
{
    if (on)
        ex_gl_watch_current(gl);
    return gl->way->make_current(gl->self, on);
}

void ex_gl_log(void *user, const char *message)
{
    (void)user;
    fprintf(stderr, "%s\n", message);
}

glbk_proc_fn ex_gl_get_proc(const char *name, void *user)
{
    ex_gl *gl = user;
    glbk_proc_fn proc = gl->way->get_proc(name);
    return gl->watched ? ex_gl_watch(name, proc, gl->way->get_proc) : proc;
}

void *ex_gl_self(ex_gl *gl) { return gl->self; }
