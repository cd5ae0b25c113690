/* gl_test.h - what the tests on GL share: the drivers that they run on, a context with glbk_context for each test, and
   the check that it saw no GL error and no message of type error.

   A program runs its tests once for each way to a context, each in a process of its own, since drivers read their
   switches once: MESA_GL_VERSION_OVERRIDE gives the real floor of 3.3 or ES 3.0, and -GL_ARB_ES2_compatibility the
   rules by which framebuffers of 3.3 are complete; GALLIUM_DRIVER=softpipe a second, slow driver; es30bare hides the
   extensions that make floats renderable, since Mesa refuses to turn them off. Use:

       static void draws(void **state) { gl_test *t = *state; ... t->gl ... }

       int main(int count, char **values)
       {
           struct CMUnitTest tests[] = { gl_unit_test(draws) };
           GL_TEST_MAIN(values, tests, GL_CORE45 | GL_CORE33 | GL_ES30);
       }

   Include cmocka.h and gl_backend.h with its implementation before. A way that fails is a skipped test with its reason,
   and with CI=true a failure. DAPPLE_GL=NAME runs one way alone, without a process of its own; DAPPLE_GL_WAYS="NAME
   NAME" only those of a program's ways that it names, or the program's first where it has none of them. */
#ifndef GL_TEST_H
#define GL_TEST_H

#include "../../examples/common/gl_context.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum {
    GL_CORE45 = 1, GL_CORE33 = 2, GL_ES30 = 4, GL_OSMESA = 8, GL_SOFTPIPE = 16, GL_GLFW = 32,
    GL_ES30_BARE = 64, GL_ES32 = 128, GL_WEBGL2 = 256,
    /* ES 3.0 with its extensions for floats differs from 3.3 in the first lines of shaders alone, which browsers run,
       too; without them it takes other formats. */
    GL_USUAL = GL_CORE45 | GL_CORE33 | GL_ES30_BARE, GL_ALL = 255
};

typedef struct gl_way {
    const char *name;
    int         bit, window;
    ex_gl_api   api;
    int         es;
    const char *switches[3];        /* NAME=value, for the environment */
} gl_way;

static const gl_way gl_ways[] = {
    { "core45", GL_CORE45, 0, EX_GL_EGL, 0, { NULL, NULL, NULL } },
    { "core33", GL_CORE33, 0, EX_GL_EGL, 0, { "MESA_GL_VERSION_OVERRIDE=3.3", "MESA_GLSL_VERSION_OVERRIDE=330",
                                              "MESA_EXTENSION_OVERRIDE=-GL_ARB_ES2_compatibility" } },
    { "es30", GL_ES30, 0, EX_GL_EGL, 1, { "MESA_GLES_VERSION_OVERRIDE=3.0", NULL, NULL } },
    { "es30bare", GL_ES30_BARE, 0, EX_GL_EGL, 1, { "MESA_GLES_VERSION_OVERRIDE=3.0", NULL, NULL } },
    { "es32", GL_ES32, 0, EX_GL_EGL, 1, { NULL, NULL, NULL } },
    { "osmesa", GL_OSMESA, 0, EX_GL_OSMESA, 0, { NULL, NULL, NULL } },
    { "softpipe", GL_SOFTPIPE, 0, EX_GL_EGL, 0, { "GALLIUM_DRIVER=softpipe", NULL, NULL } },
    { "glfw", GL_GLFW, 1, EX_GL_EGL, 0, { NULL, NULL, NULL } },
    { "webgl2", GL_WEBGL2, 0, EX_GL_HEADLESS, 1, { NULL, NULL, NULL } }     /* tools/check-browser starts it */
};

enum { GL_LOG = 4000 };

typedef struct gl_test {
    ex_gl       *context;
    glbk_context gl;
    char         log[GL_LOG];       /* the last line of the library's log */
    unsigned     expected_errors;   /* messages of type error that a test provokes; -1u: any number */
} gl_test;

/* The way that this process was started for. */
static inline const gl_way *gl_this_way(void)
{
    const char *name = getenv("DAPPLE_GL");
    size_t i;
    for (i = 0; name && i < sizeof gl_ways / sizeof gl_ways[0]; i++)
        if (strcmp(gl_ways[i].name, name) == 0) return &gl_ways[i];
    return NULL;
}

static inline ex_gl *gl_new_context(char *error)
{
    const gl_way *way = gl_this_way();
    ex_gl_options options;
    memset(&options, 0, sizeof options);
    options.api = way->api;
    options.es = way->es;
    options.debug = 1;
    options.hidden = 1;
    return way->window ? ex_gl_create_window(&options, error) : ex_gl_create(&options, error);
}

/* Mesa gives the version that is asked for, and interpolates exactly; other drivers need neither. */
static inline int gl_is_mesa(gl_test *t)
{
    enum { VERSION_TEXT = 0x1F02 };
    return strstr((const char *)t->gl.gl.GetString(VERSION_TEXT), "Mesa") != NULL;
}

/* OSMesa's library keeps some memory of each context that it destroyed; under the address sanitizer only that is
 * excused. */
#if defined(__SANITIZE_ADDRESS__)                                   /* gcc */
#define GL_TEST_LEAKS
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define GL_TEST_LEAKS
#endif
#endif
#if defined(GL_TEST_LEAKS)
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libOSMesa"; }
#endif

/* ---- es30bare ---- */

typedef const uint8_t *(GLBK_CALL *gl_string_proc)(uint32_t name, uint32_t index);
static gl_string_proc gl_real_string;

static inline const uint8_t *GLBK_CALL gl_bare_string(uint32_t name, uint32_t index)
{
    static const char *const hidden[] = { "GL_EXT_color_buffer_float", "GL_EXT_float_blend",
                                          "GL_OES_texture_float_linear" };
    const uint8_t *text = gl_real_string(name, index);
    size_t i;
    for (i = 0; text && i < 3; i++)
        if (strcmp((const char *)text, hidden[i]) == 0) return (const uint8_t *)"GL_DAPPLE_hidden";
    return text;
}

static inline glbk_proc_fn gl_bare_get_proc(const char *name, void *user)
{
    glbk_proc_fn proc = ex_gl_get_proc(name, user);
    if (strcmp(name, "glGetStringi") != 0) return proc;
    memcpy(&gl_real_string, &proc, sizeof proc);
    return (glbk_proc_fn)gl_bare_string;
}

static inline glbk_get_proc_fn gl_get_proc(void)
{
    return gl_this_way()->bit == GL_ES30_BARE ? gl_bare_get_proc : ex_gl_get_proc;
}

/* ---- a test's context ---- */

/* The last line of any log, and how many lines there were. */
static char gl_line[GL_LOG];
static unsigned gl_lines;

/* The last line of the library's log; user: room for GL_LOG characters. */
static inline void gl_log(void *user, const char *message)
{
    snprintf((char *)user, GL_LOG, "%s", message);
    snprintf(gl_line, sizeof gl_line, "%s", message);
    gl_lines++;
}

static inline int gl_setup(void **state)
{
    char error[EX_ERROR_SIZE];
    gl_test *t = (gl_test *)calloc(1, sizeof *t);
    glbk_desc desc;

    if (!t) return -1;
    *state = t;
    t->context = gl_new_context(error);
    if (!t->context) {
        const char *ci = getenv("CI");
        printf("skip: %s\n", error);
        return ci && strcmp(ci, "true") == 0 ? -1 : 0;
    }
    memset(&desc, 0, sizeof desc);
    desc.get_proc_fn = gl_get_proc();
    desc.user = t->context;
    desc.system.log = gl_log;
    desc.system.user = t->log;
    if (glbk_init(&t->gl, &desc) == GLBK_OK) return 0;
    printf("glbk_init: %s\n", t->log);
    return -1;
}

/* Fails where a test left an error behind. */
static inline int gl_teardown(void **state)
{
    gl_test *t = (gl_test *)*state;
    int bad = 0;
    if (t->context) {
        const char *last = "";
        unsigned errors = ex_gl_errors(t->context, &last);
        if (!t->gl.lost && t->gl.gl.GetError && t->gl.gl.GetError()) {
            printf("a GL error is left: the last message: %s\n", last);
            bad = 1;
        }
        if (t->expected_errors != ~0u && errors != t->expected_errors) {
            printf("%u messages of type error, the last: %s\n", errors, last);
            bad = 1;
        }
        glbk_free(&t->gl);
    }
    ex_gl_free(t->context);
    free(t);
    return bad ? -1 : 0;
}

/* The first line of a test: skips it where there is no context. */
#define GL_TEST(t, state)                       \
    gl_test *t = (gl_test *)*(state);           \
    if (!t->context) { skip(); return; }

#define gl_unit_test(f) cmocka_unit_test_setup_teardown(f, gl_setup, gl_teardown)

#define assert_glbk(t, call) gl_assert_ok(t, call, #call, __FILE__, __LINE__)
static inline void gl_assert_ok(gl_test *t, glbk_result result, const char *call, const char *file, int line)
{
    if (result == GLBK_OK) return;
    printf("%s:%d: %s: %s\n%s\n", file, line, call, glbk_result_text(result), t->log);
    assert_int_equal(result, GLBK_OK);
}

/* Corners of triangles are moved to a grid of so many lines a pixel: at least 16; 256 nearly everywhere, and no test
   asks for more. */
static inline double gl_corner_grid(const gl_test *t)
{
    int32_t bits = 0;
    t->gl.gl.GetIntegerv(0x0D50 /* SUBPIXEL_BITS */, &bits);
    return bits >= 8 ? 256.0 : 1 << bits;
}

static inline glbk_texture gl_texture(gl_test *t, glbk_format format, uint32_t width, uint32_t height, const void *data)
{
    glbk_texture_desc d;
    glbk_texture texture;
    memset(&d, 0, sizeof d);
    d.format = format;
    d.width = width;
    d.height = height;
    d.data = data;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &texture));
    return texture;
}

/* One colour target and its texture. */
typedef struct gl_canvas { glbk_texture color, depth; glbk_target target; } gl_canvas;

static inline gl_canvas gl_canvas_make(gl_test *t, glbk_format format, uint32_t width, uint32_t height, int depth)
{
    gl_canvas c;
    glbk_texture_desc d;
    glbk_target_desc targets;
    memset(&c, 0, sizeof c);
    memset(&d, 0, sizeof d);
    memset(&targets, 0, sizeof targets);
    d.format = format;
    d.width = width;
    d.height = height;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &c.color));
    targets.color[0] = &c.color;
    d.format = GLBK_FORMAT_DEPTH24;
    if (depth) {
        assert_glbk(t, glbk_texture_create(&t->gl, &d, &c.depth));
        targets.depth = &c.depth;
    }
    assert_glbk(t, glbk_target_create(&t->gl, &targets, &c.target));
    return c;
}

static inline void gl_canvas_free(gl_test *t, gl_canvas *c)
{
    glbk_target_free(&t->gl, &c->target);
    glbk_texture_free(&t->gl, &c->color);
    glbk_texture_free(&t->gl, &c->depth);
}

/* ---- one process a way ---- */

static inline int gl_run_way(char **values, const gl_way *way)
{
    pid_t child;
    int status = 0, i;

    fflush(stdout);
    child = fork();
    if (child == 0) {
        setenv("DAPPLE_GL", way->name, 1);
        for (i = 0; i < 3 && way->switches[i]; i++) {
            char text[200];
            char *equal;
            snprintf(text, sizeof text, "%s", way->switches[i]);
            equal = strchr(text, '=');
            *equal = 0;
            setenv(text, equal + 1, 1);
        }
        if (way->window && !getenv("DISPLAY"))
            execlp("xvfb-run", "xvfb-run", "-a", values[0], (char *)NULL);  /* without it: GLFW says what is missing */
        execv(values[0], values);
        _exit(127);
    }
    if (child < 0 || waitpid(child, &status, 0) < 0) return 1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

/* Those ways of a program that DAPPLE_GL_WAYS asks for. */
static inline int gl_asked_ways(int ways)
{
    const char *asked = getenv("DAPPLE_GL_WAYS");
    char list[200], name[40];
    int named = 0;
    size_t i;
    if (!asked || !*asked) return ways;
    snprintf(list, sizeof list, " %s ", asked);
    for (i = 0; i < sizeof gl_ways / sizeof gl_ways[0]; i++) {
        snprintf(name, sizeof name, " %s ", gl_ways[i].name);
        if (strstr(list, name)) named |= gl_ways[i].bit;
    }
    return ways & named ? ways & named : ways & -ways;
}

/* 1 in the parent, when all ways are done. */
static inline int gl_run_ways(char **values, int ways, int *status)
{
    size_t i;
    if (gl_this_way()) return 0;
    *status = 0;
    ways = gl_asked_ways(ways);
    for (i = 0; i < sizeof gl_ways / sizeof gl_ways[0]; i++)
        if (ways & gl_ways[i].bit && gl_run_way(values, &gl_ways[i]) != 0) *status = 1;
    return 1;
}

static inline void gl_name_tests(struct CMUnitTest *tests, size_t count)
{
    static char names[64][100];
    size_t i;
    for (i = 0; i < count && i < 64; i++) {
        snprintf(names[i], sizeof names[i], "%s/%s", gl_this_way()->name, tests[i].name);
        tests[i].name = names[i];
    }
}

#define GL_TEST_MAIN(values, tests, ways)                               \
    do {                                                                \
        int gl_status;                                                  \
        if (gl_run_ways(values, ways, &gl_status)) return gl_status;    \
        gl_name_tests(tests, sizeof tests / sizeof tests[0]);           \
        return cmocka_run_group_tests(tests, NULL, NULL);               \
    } while (0)

#endif
