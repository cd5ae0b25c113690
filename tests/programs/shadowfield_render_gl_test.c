/* shadowfield_render_gl_test - `render --technique shadowfield --backend gl` as a user calls it: the same points as
   --backend cpu, within 1 % relative RMSE. What is left of a difference: the CPU orders occluders for 16 points at a
   time, GL for each. */
#define _POSIX_C_SOURCE 200809L
#include "program.h"

static void agree(const char *scene)
{
    compare_back_ends("shadowfield --size 48x36", 0.01, scene);
}

/* Small fields: this is about agreement, not about quality. */
#define SMALL " --set position_side=2 --set shell_count=3 --set point_spacing=0.2"

static void a_sky_on_instances_lights_alike(void **state)
{
    (void)state;
    agree("--scene builtin:chess --frames 2" SMALL);
}

static void spots_and_sun_light_glossy_robots_alike(void **state)
{
    (void)state;
    agree("--scene builtin:robots --set materials=full --set gloss=phong --set bands=3 --light sun:1,1,1,2" SMALL);
}

/* glTF's BRDF: pieces whose textures are laid over points, and gloss=auto is it on both. */
static void metal_chess_lights_alike(void **state)
{
    (void)state;
    agree("--scene builtin:chess --env builtin:overcast --set materials=full --set bands=3 --set roughness=0.4 "
          "--set metallic=1" SMALL);
}

static void logarithms_are_added_alike(void **state)
{
    (void)state;
    agree("--scene builtin:chess --env builtin:overcast --set product=exp --set bands=2" SMALL);
    expect(1, "product=exp and, on GL, gloss=gltf need basis=sh",
           "--technique shadowfield --scene builtin:chess --set basis=haar --set product=exp --out a.pfm");
}

/* A sky and self-visibility in wavelets. */
static void wavelets_light_alike(void **state)
{
    (void)state;
    agree("--scene builtin:knot --env builtin:overcast --set basis=haar --set cube_side=8" SMALL);
    agree("--scene builtin:knot --env builtin:overcast --set basis=haar --set cube_side=8 --set materials=full "
          "--set gloss=phong --set roughness=0.4" SMALL);
    expect(1, "product=exp and, on GL, gloss=gltf need basis=sh",
           "--technique shadowfield --backend gl --scene builtin:chess --set basis=haar --set materials=full --out a.pfm");
}

/* A close look at a bullet, which glows with 420: the other lamps light it, its own light does not. It was black. */
static void bullets_are_lit_by_others(void **state)
{
    static const char look[] = "--scene builtin:robots --camera 0.6,4,8.4,-4.3078,0.8862,1.5284,0.5";
    char line[300];
    (void)state;
    snprintf(line, sizeof line, "--technique csm --size 48x36 %s --out other.pfm", look);
    expect(0, "", line);
    snprintf(line, sizeof line, "--technique shadowfield --size 48x36 %s%s --out a.pfm", look, SMALL);
    expect(0, "", line);
    assert_int_equal(run("compare", "a.pfm other.pfm"), 0);
    printf("a bullet: %.2f times the light of csm\n", number("mean_ratio"));
    assert_true(number("mean_ratio") > 0.5 && number("mean_ratio") < 2);        /* small fields: its dark side is lit */
    snprintf(line, sizeof line, "%s%s", look, SMALL);
    agree(line);
}

static void a_moving_video_lights_alike(void **state)
{
    (void)state;
    agree("--scene builtin:explosion --frames 2" SMALL);
}

/* 23 bones, whose points have self-visibility of their own. */
static void bones_that_follow_light_alike(void **state)
{
    (void)state;
    agree("--scene builtin:figure --env builtin:overcast --set bones=1 --frames 3" SMALL);
}

/* Objects and lights that are meshes, drawn and projected on OpenGL: some samples at edges are others. */
static void fields_built_on_gl_light_alike(void **state)
{
    static const char *const scenes[] = { "chess", "explosion" }, *const ways[] = { "cpu", "gpu" };
    (void)state;
    expect(1, "build=gpu needs --backend gl",
           "--technique shadowfield --scene builtin:chess --set build=gpu --out a.pfm");
    for (int i = 0; i < 4; i++) {
        char arguments[300];
        snprintf(arguments, sizeof arguments, "--technique shadowfield --backend gl --size 48x36 --scene builtin:%s%s "
                 "--set build=%s --out %s.pfm", scenes[i / 2], SMALL, ways[i % 2], ways[i % 2]);
        if (run("render", arguments) != 0) {
            if (!strstr(output, "EGL") && !strstr(output, "no GL context"))
                fail_msg("render %s: %s", arguments, output);
            printf("skip: %s\n", output);
            skip();
        }
        if (i % 2 == 0) continue;
        assert_int_equal(run("compare", "gpu.pfm cpu.pfm"), 0);
        printf("%s: relative_rmse %.1e\n", scenes[i / 2], number("relative_rmse"));
        assert_true(number("relative_rmse") <= 0.01);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(a_sky_on_instances_lights_alike),
                                        cmocka_unit_test(spots_and_sun_light_glossy_robots_alike),
                                        cmocka_unit_test(metal_chess_lights_alike),
                                        cmocka_unit_test(logarithms_are_added_alike),
                                        cmocka_unit_test(wavelets_light_alike),
                                        cmocka_unit_test(bullets_are_lit_by_others),
                                        cmocka_unit_test(a_moving_video_lights_alike),
                                        cmocka_unit_test(bones_that_follow_light_alike),
                                        cmocka_unit_test(fields_built_on_gl_light_alike) };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
