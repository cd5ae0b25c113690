/* ism_render_gl_test - `render --technique ism --backend gl` as a user calls it: the same VPLs and points as --backend cpu, so
   that the pictures agree far within the 2 % relative RMSE that are promised. */
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

static char folder[] = "/tmp/dapple-ism-gl-XXXXXX";
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
        snprintf(arguments, sizeof arguments, "--technique ism --backend %s --size 48x36 --set vpls=64 --set points=256 --set tile=32 --set rsm=32 --set shadow=128 %s --out %s.pfm", ways[i], scene,
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
    if (!(error <= 0.02))
        fail_msg("%s: relative_rmse %.5f", scene, error);
}

static void emitter_in_a_room(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:cornell --set near=sphere");
}

static void leaves_with_holes_under_a_sky(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:plant --env builtin:sky --samples 64");
}

static void instances_and_lamps(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:chess --light sun:1,1,1,2 --light sphere:2,2.5,1,0.4,6 --light spot:0,4,1,0,-1,-0.2,200");
}

static void two_bounces_round_a_corner(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:uroom --set bounces=2 --set projection=lobe");
}

static void moving_cloth(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:cloth --frames 3 --set lazy=2");
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
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(emitter_in_a_room),        cmocka_unit_test(leaves_with_holes_under_a_sky),
        cmocka_unit_test(instances_and_lamps),      cmocka_unit_test(two_bounces_round_a_corner),
        cmocka_unit_test(moving_cloth)
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
