/* envsh_render_gl_test - `render --technique envshadow --backend gl` as a user calls it: the picture of --backend cpu within
   1 % relative RMSE, for instances, motion, holes of alpha masks, clusters, channels, a sun and every filter. */
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

static char folder[] = "/tmp/dapple-envsh-gl-XXXXXX";
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
        snprintf(arguments, sizeof arguments, "--technique envshadow --backend %s --size 64x48 %s --out %s.pfm", ways[i],
                 scene, ways[i]);
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
    printf("%s: relative_rmse %.1e\n", scene, error);
    if (!(error <= 0.01))
        fail_msg("%s: relative_rmse %.5f", scene, error);
}

static void instances_by_the_penumbra_filter(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:chess --set lights=16 --set m=128");
}

static void cloth_in_motion_in_clusters(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:cloth --frames 3 --set lights=30 --set cluster=7 --set filter=smooth");
}

static void an_explosion_under_a_sun_in_channels(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:explosion --frames 3 --light sun:1,1,0.4,2 --env builtin:studio "
                      "--set emitters=0 --set lights=14 --set rgba=1 --set m=200 --samples 1");
}

static void leaves_with_holes(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:plant --set lights=40 --set filter=pcf --env builtin:sky --set env_rotation=70");
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
    const struct CMUnitTest tests[] = { cmocka_unit_test(instances_by_the_penumbra_filter),
                                        cmocka_unit_test(cloth_in_motion_in_clusters),
                                        cmocka_unit_test(an_explosion_under_a_sun_in_channels),
                                        cmocka_unit_test(leaves_with_holes) };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
