/* rsm_render_gl_test - `render --technique rsm --backend gl` as a user calls it: the pictures of --backend cpu, within 1 %
   relative RMSE, for lights, textures, masks, instances, moving scenes and all modes. The maps are drawn by GL and differ in
   a texel here and there on edges; the choice of samples is the same. */
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

static char folder[] = "/tmp/dapple-rsm-gl-XXXXXX";
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
        snprintf(arguments, sizeof arguments, "--technique rsm --backend %s --size 64x48 %s --out %s.pfm", ways[i], scene,
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
    printf("%s: %.5f\n", scene, error);
    if (!(error <= 0.01))
        fail_msg("%s: relative_rmse %.5f", scene, error);
}

static void emitter_in_a_room(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:cornell --samples 64 --set m=64 --set lights=2");
}

static void spot_interpolated(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:cornell --set emitters=0 --light spot:0.278,0.54,0.1,0,-0.8,0.6,70,2 --set only=indirect "
                      "--samples 100 --set m=64 --set mode=interpolated --set pattern=mixed");
}

static void lamps_denoised_over_frames(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:uroom --light point:0.3,1.2,0.2 --light spot:0,1.5,0.5,0,-1,0.1,150 --samples 64 "
                      "--set m=48 --set mode=denoised --frames 3");
}

static void sun_on_instances_and_masks(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:chess --samples 200 --set m=256");
    compare_back_ends("--scene builtin:plant --samples 200 --set m=256 --light sun:1,1,1");
}

static void cloth_moves(void **state)
{
    (void)state;
    compare_back_ends("--scene builtin:cloth --samples 100 --set m=256 --light sun:1,2,1 --frames 2 --set pattern=equation3 --set noise=1");
    compare_back_ends("--scene builtin:robots --samples 100 --set m=256 --light sun:1,2,1 --frames 2 --set pattern=poisson");
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
    const struct CMUnitTest tests[] = { cmocka_unit_test(emitter_in_a_room), cmocka_unit_test(spot_interpolated),
                                        cmocka_unit_test(lamps_denoised_over_frames),
                                        cmocka_unit_test(sun_on_instances_and_masks), cmocka_unit_test(cloth_moves) };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
