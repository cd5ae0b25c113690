/* debug_test - DAPPLE_GL_DEBUG=1, by which the tests of programs know that GL saw no error: a program with one says so
   and does not end with 0; and with one of those that browsers have and drivers let pass. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "gl_context.h"

enum { NO_GL = 77 };

/* What a program does that draws: an error of a call in the middle, asked for or not, or none. */
static void program(int with_error, int asks)
{
    const ex_gl_options options = { EX_GL_HEADLESS, 0, 0, 0, 0, 0, 0, 0, 0, NULL };
    char error[EX_ERROR_SIZE];
    ex_gl *gl = ex_gl_create(&options, error);
    void (GLBK_CALL *enable)(uint32_t);
    uint32_t (GLBK_CALL *get_error)(void);
    glbk_proc_fn proc;
    if (!gl) exit(NO_GL);
    proc = ex_gl_get_proc("glEnable", gl);
    memcpy(&enable, &proc, sizeof enable);
    proc = ex_gl_get_proc("glGetError", gl);
    memcpy(&get_error, &proc, sizeof get_error);
    if (with_error) enable(0xFFFF);
    if (asks) get_error();
    ex_gl_free(gl);
    exit(0);
}

/* A draw whose program declares a sampler2D and does not read it, with one thing or another on its unit. */
enum { NOTHING, BYTES, DEPTHS, INTEGERS, COMPARED, ITSELF, UNITS, UNITS_WRONG = INTEGERS };

static glbk_texture make_texture(glbk_context *gl, glbk_format format, glbk_sampling sampling)
{
    glbk_texture_desc d;
    glbk_texture texture;
    memset(&d, 0, sizeof d);
    d.format = format;
    d.width = d.height = 2;
    d.sampling = sampling;
    if (glbk_texture_create(gl, &d, &texture) != GLBK_OK) exit(3);
    return texture;
}

static void draw_program(int unit)
{
    static const char text[] = "uniform sampler2D map;\nuniform int reads;\nlayout(location = 0) out vec4 c;\n"
                               "void main() { c = reads != 0 ? texture(map, vec2(0.5)) : vec4(1.0); }\n";
    const ex_gl_options options = { EX_GL_HEADLESS, 0, 0, 0, 0, 0, 0, 0, 0, NULL };
    const glbk_source source = { NULL, text, NULL, NULL, NULL, NULL, { NULL }, { { 0, 0 } } };
    char error[EX_ERROR_SIZE];
    ex_gl *context = ex_gl_create(&options, error);
    glbk_texture textures[UNITS];
    glbk_target_desc to;
    glbk_target target;
    glbk_program program;
    glbk_context gl;
    glbk_desc desc;
    glbk_pass pass;
    if (!context) exit(NO_GL);
    memset(&desc, 0, sizeof desc);
    memset(&to, 0, sizeof to);
    memset(&pass, 0, sizeof pass);
    desc.get_proc_fn = ex_gl_get_proc;
    desc.user = context;
    if (glbk_init(&gl, &desc) != GLBK_OK || glbk_program_compile(&gl, &source, &program) != GLBK_OK) exit(3);
    memset(textures, 0, sizeof textures);
    textures[BYTES] = make_texture(&gl, GLBK_FORMAT_RGBA8, GLBK_SAMPLING_NEAREST);
    textures[DEPTHS] = make_texture(&gl, GLBK_FORMAT_DEPTH24, GLBK_SAMPLING_NEAREST);
    textures[INTEGERS] = make_texture(&gl, GLBK_FORMAT_RGBA32UI, GLBK_SAMPLING_NEAREST);
    textures[COMPARED] = make_texture(&gl, GLBK_FORMAT_DEPTH24, GLBK_SAMPLING_COMPARE);
    textures[ITSELF] = make_texture(&gl, GLBK_FORMAT_RGBA8, GLBK_SAMPLING_NEAREST);
    to.color[0] = &textures[ITSELF];
    if (glbk_target_create(&gl, &to, &target) != GLBK_OK) exit(3);
    pass.target = &target;
    if (glbk_begin(&gl, &pass, &program) != GLBK_OK) exit(3);
    glbk_bind_texture(&gl, 0, &textures[unit]);
    glbk_draw_screen(&gl);
    if (gl.gl.GetError()) exit(4);              /* the driver does not mind */
    ex_gl_free(context);
    exit(0);
}

/* unit: of draw_program, or -1 for program */
static int run_program(int unit, int debug, int with_error, int asks, char *said, size_t size)
{
    int ends[2], status;
    size_t used = 0;
    ssize_t got;
    pid_t child;
    fflush(NULL);
    assert_int_equal(pipe(ends), 0);
    child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        if (debug) setenv("DAPPLE_GL_DEBUG", "1", 1);
        else unsetenv("DAPPLE_GL_DEBUG");
        dup2(ends[1], 2);
        close(ends[0]);
        if (unit < 0) program(with_error, asks);
        draw_program(unit);
    }
    close(ends[1]);
    while (used + 1 < size && (got = read(ends[0], said + used, size - 1 - used)) > 0) used += (size_t)got;
    said[used] = 0;
    close(ends[0]);
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static void errors_are_told(void **state)
{
    const char *ci = getenv("CI");
    char said[2000];
    int asks;
    (void)state;
    if (run_program(-1, 1, 0, 0, said, sizeof said) == NO_GL) {
        printf("skip: no OpenGL\n");
        assert_false(ci && strcmp(ci, "true") == 0);
        skip();
    }
    assert_int_equal(run_program(-1, 1, 0, 0, said, sizeof said), 0);
    assert_null(strstr(said, "GL error"));
    for (asks = 0; asks < 2; asks++) {          /* one that the program itself took counts too */
        assert_int_equal(run_program(-1, 1, 1, asks, said, sizeof said), 1);
        assert_non_null(strstr(said, "GL error"));
        assert_int_equal(run_program(-1, 0, 1, asks, said, sizeof said), 0);
        assert_null(strstr(said, "GL error"));
    }
}

/* Nothing of the drivers' is needed for these. */
static void wrong_units_are_told(void **state)
{
    static const char *const words[UNITS] = { NULL, NULL, NULL, "map, of floats, has a texture of unsigned integers",
                                              "map, of floats, has a texture of compared depths",
                                              "a draw to the texture that the sampler map has" };
    char said[2000];
    int unit;
    (void)state;
    if (run_program(NOTHING, 1, 0, 0, said, sizeof said) == NO_GL) skip();      /* which errors_are_told told */
    for (unit = 0; unit < UNITS; unit++) {
        assert_int_equal(run_program(unit, 1, 0, 0, said, sizeof said), unit >= UNITS_WRONG);
        if (words[unit]) assert_non_null(strstr(said, words[unit]));
        else assert_null(strstr(said, "GL error"));
        assert_int_equal(run_program(unit, 0, 0, 0, said, sizeof said), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(errors_are_told), cmocka_unit_test(wrong_units_are_told) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
