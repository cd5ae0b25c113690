/* sfield_render_gl_test - `render --technique shadowfield --backend gl` as a user calls it: the same points as --backend cpu,
   within 1 % relative RMSE. What is left of a difference: the CPU orders occluders for 16 points at a time, GL for each. */
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

static char folder[] = "/tmp/dapple-sfield-gl-XXXXXX";
static char output[4096];

static int run(const char *program, const char *arguments)
{
    const char *build = getenv("BUILD");
    char command[1024];
    FILE *pipe;
    int status;
    snprintf(command, sizeof command, "cd %s && %s%s/%s %s 2>&1", folder, build && *build == '/' ? "" : "$OLDPWD/",
             build && *build ? build : "build", program, arguments);
    pipe = popen(command, "r");
    assert_non_null(pipe);
    output[fread(output, 1, sizeof output - 1, pipe)] = 0;
    status = pclose(pipe);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static void compare_back_ends(const char *scene)
{
    const char *ways[] = { "cpu", "gl" }, *at;
    double error;
    for (int i = 0; i < 2; i++) {
        char arguments[700];
        snprintf(arguments, sizeof arguments, "--technique shadowfield --backend %s --size 48x36 %s --out %s.pfm", ways[i], scene,
                 ways[i]);
        if (run("render", arguments) == 0)
            continue;
        if (i == 1 && (strstr(output, "EGL") || strstr(output, "no GL context"))) {
            printf("skip: %s\n", output);
            skip();
        }
        fail_msg("render %s: %s", arguments, output);
    }
    assert_int_equal(run("compare", "gl.pfm cpu.pfm"), 0);
    at = strstr(output, "\"relative_rmse\": ");
    assert_non_null(at);
    error = strtod(at + strlen("\"relative_rmse\": "), NULL);
    if (!(error <= 0.01))
        fail_msg("%s: relative_rmse %.5f", scene, error);
}

/* Small fields: this is about agreement, not about quality. */
#define SMALL " --set position_side=2 --set shells=3 --set spacing=0.2"

static void sky_on_instances(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:chess --frames 2" SMALL);
}

static void spots_and_sun_on_glossy_robots(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:robots --set materials=full --set bands=3 --light sun:1,1,1,2" SMALL);
}

static void moving_video_light(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:explosion --frames 2" SMALL);
}

static int open_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int close_folder(void **state)
{
    char command[64];
    (void)state;
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(sky_on_instances), cmocka_unit_test(spots_and_sun_on_glossy_robots),
                                        cmocka_unit_test(moving_video_light) };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
