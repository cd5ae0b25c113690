/* program.h - tests that call render and its like as a user does: a scratch folder, a run with its output, a number of
   the JSON. Define _POSIX_C_SOURCE 200809L first. */
#ifndef PROGRAM_H
#define PROGRAM_H

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

#include "json.h"

static char folder[] = "/tmp/dapple-test-XXXXXX";
static char output[4096];

static inline int open_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static inline int close_folder(void **state)
{
    char command[64];
    (void)state;
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command);
}

/* Where the build wrote a file, for programs that run in the scratch folder. Returns 0, or -1. */
static inline int built_file(const char *name, char *path, size_t room)
{
    const char *build = getenv("BUILD");
    char here[500] = "";
    if ((!build || *build != '/') && !getcwd(here, sizeof here)) return -1;
    snprintf(path, room, "%s%s%s/%s", here, *here ? "/" : "", build && *build ? build : "build", name);
    return 0;
}

/* Runs a program of the build folder in the scratch folder, its output into `output`; returns the exit status, which is
   not 0 where GL had an error. */
static inline int run(const char *program, const char *arguments)
{
    const char *build = getenv("BUILD");
    char command[1024];
    FILE *pipe;
    int status;
    snprintf(command, sizeof command, "cd %s && DAPPLE_GL_DEBUG=1 %s%s/%s %s 2>&1", folder,
             build && *build == '/' ? "" : "$OLDPWD/", build && *build ? build : "build", program, arguments);
    pipe = popen(command, "r");
    assert_non_null(pipe);
    output[fread(output, 1, sizeof output - 1, pipe)] = 0;
    status = pclose(pipe);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static inline void expect(int status, const char *text, const char *arguments)
{
    int found = run("render", arguments);
    if (found != status || !strstr(output, text))
        fail_msg("render %s: status %d, expected %d and \"%s\": %s", arguments, found, status, text, output);
}

static inline double number(const char *name) { return json_number(output, name); }

static inline void need_reference(void)
{
    run("render", "--list");
    if (strstr(output, "needs Embree")) {
        printf("skip: needs Embree\n");
        skip();
    }
}

/* render must succeed; a run that found no GL context skips the test. */
static inline void render_or_skip(const char *arguments)
{
    if (run("render", arguments) == 0)
        return;
    if (strstr(arguments, "--backend gl") && (strstr(output, "EGL") || strstr(output, "no GL context"))) {
        printf("skip: %s\n", output);
        skip();
    }
    fail_msg("render %s: %s", arguments, output);
}

/* Renders with both back ends: technique (and options), scene; on GL by compute, where it has that, and without. Their
   relative RMSE must be at most `limit`. */
static inline void compare_back_ends(const char *technique, double limit, const char *scene)
{
    static const char *const ways[] = { "cpu", "gl --set compute=1", "gl --set compute=0" };
    int computes = 1;
    for (int i = 0; i < 2 + computes; i++) {
        char arguments[700];
        double error;
        snprintf(arguments, sizeof arguments, "--technique %s --backend %s %s --out %s.pfm --json -", technique,
                 ways[i], scene, i ? "gl" : "cpu");
        render_or_skip(arguments);
        if (i == 0)
            continue;
        computes = strstr(output, "\"path\": \"compute\"") != NULL || i == 2;
        assert_int_equal(run("compare", "gl.pfm cpu.pfm"), 0);
        error = number("relative_rmse");
        printf("%s: %s: relative_rmse %.1e\n", scene, ways[i], error);
        if (!(error <= limit))
            fail_msg("%s: %s: relative_rmse %.5f", scene, ways[i], error);
    }
}

#endif
