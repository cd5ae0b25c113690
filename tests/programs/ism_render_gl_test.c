/* ism_render_gl_test - `render --technique ism --backend gl` as a user calls it: the same VPLs and points as --backend
   cpu, so that the pictures agree far within the 2 % relative RMSE that are promised. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>

#include "program.h"
#include "masked.h"

static void agree(const char *scene)
{
    compare_back_ends("ism --size 48x36 --set vpl_count=64 --set surfel_count=256 --set tile_side=32 "
                      "--set rsm_side=32 --set shadow_map_side=128",
                      0.02, scene);
}

static void an_emitter_in_a_room_lights_alike(void **state)
{
    (void)state;
    agree("--scene builtin:cornell --set near_mode=sphere");
}

static void leaves_under_a_sky_are_lit_alike(void **state)
{
    (void)state;
    agree("--scene builtin:plant --env builtin:sky --samples 64");
}

static void a_board_with_holes_is_lit_alike(void **state)
{
    (void)state;
    need_masked();
    agree("--scene " MASKED " --light sun:0.3,0.9,0.2");
}

static void instances_and_lamps_are_lit_alike(void **state)
{
    (void)state;
    agree("--scene builtin:chess --light sun:1,1,1,2 --light sphere:2,2.5,1,0.4,6 --light spot:0,4,1,0,-1,-0.2,200");
}

static void two_bounces_round_a_corner_light_alike(void **state)
{
    (void)state;
    agree("--scene builtin:uroom --set bounces=2 --set projection=lobe");
}

static void a_moving_cloth_with_lazy_maps_is_lit_alike(void **state)
{
    (void)state;
    agree("--scene builtin:cloth --frames 3 --set lazy_frames=2");
}

/* The share that a rule takes off light near by is the CPU's. 64 VPLs, 16 of them a pixel. Depths differ by rounding:
   one texel of a map on the other side changes one of 1728 x 16 pairs of pixel and VPL; 1e-3 is room for a dozen. */
static void the_energy_that_rules_take_is_the_cpus(void **state)
{
    static const char *const rules[] = { "clamp --set clamp=2", "sphere", "mean --set clamp=3" };
    (void)state;
    for (int i = 0; i < 3; i++) {
        double lost[2];
        for (int gl = 0; gl < 2; gl++) {
            char arguments[512];
            snprintf(arguments, sizeof arguments, "--technique ism --backend %s --scene builtin:cornell --size 48x36 "
                     "--samples 16 --set vpl_count=64 --set surfel_count=256 --set tile_side=32 --set rsm_side=32 "
                     "--set only=indirect --set near_mode=%s --json - --out lost.pfm", gl ? "gl" : "cpu", rules[i]);
            render_or_skip(arguments);
            lost[gl] = number("lost_energy");
        }
        printf("near=%s: lost %.6f, on GL %.6f\n", rules[i], lost[0], lost[1]);
        assert_true(lost[0] > 0.001 && lost[0] < 0.9);
        if (!(fabs(lost[0] - lost[1]) <= 1e-3 * lost[0]))
            fail_msg("near=%s: lost %g, on GL %g", rules[i], lost[0], lost[1]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(an_emitter_in_a_room_lights_alike),
                                        cmocka_unit_test(leaves_under_a_sky_are_lit_alike),
                                        cmocka_unit_test(a_board_with_holes_is_lit_alike),
                                        cmocka_unit_test(instances_and_lamps_are_lit_alike),
                                        cmocka_unit_test(two_bounces_round_a_corner_light_alike),
                                        cmocka_unit_test(a_moving_cloth_with_lazy_maps_is_lit_alike),
                                        cmocka_unit_test(the_energy_that_rules_take_is_the_cpus) };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
