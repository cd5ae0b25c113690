/* debug_test - DAPPLE_GL_DEBUG=1, by which the tests of programs know that GL saw no error: a program with one says so
   and does not end with 0. */
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
    glbk_proc proc;
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

static int run_program(int debug, int with_error, int asks, char *said, size_t size)
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
        program(with_error, asks);
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
    if (run_program(1, 0, 0, said, sizeof said) == NO_GL) {
        printf("skip: no OpenGL\n");
        assert_false(ci && strcmp(ci, "true") == 0);
        skip();
    }
    assert_int_equal(run_program(1, 0, 0, said, sizeof said), 0);
    assert_null(strstr(said, "GL error"));
    for (asks = 0; asks < 2; asks++) {          /* one that the program itself took counts too */
        assert_int_equal(run_program(1, 1, asks, said, sizeof said), 1);
        assert_non_null(strstr(said, "GL error"));
        assert_int_equal(run_program(0, 1, asks, said, sizeof said), 0);
        assert_null(strstr(said, "GL error"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(errors_are_told) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
