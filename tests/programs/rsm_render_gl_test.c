/* rsm_render_gl_test - `render --technique rsm --backend gl` as a user calls it: the pictures of --backend cpu, within
   1 % relative RMSE, for lights, textures, masks, instances, moving scenes and all modes. The maps are drawn by GL and
   differ in a texel here and there on edges; the choice of samples is the same. */
#define _POSIX_C_SOURCE 200809L
#include "program.h"
#include "masked.h"

static void agree(const char *scene)
{
    compare_back_ends("rsm --size 64x48", 0.01, scene);
}

static void an_emitter_in_a_room_lights_alike(void **state)
{
    (void)state;
    agree("--scene builtin:cornell --samples 64 --set side=64 --set light_point_count=2");
}

static void light_of_a_spot_is_interpolated(void **state)
{
    (void)state;
    agree("--scene builtin:cornell --set emitters=0 --light spot:0.278,0.54,0.1,0,-0.8,0.6,70,2 --set only=indirect "
                      "--samples 100 --set side=64 --set mode=interpolated --set pattern=mixed");
}

static void lamps_denoised_over_frames_light_alike(void **state)
{
    (void)state;
    agree("--scene builtin:uroom --light point:0.3,1.2,0.2 --light spot:0,1.5,0.5,0,-1,0.1,150 --samples 64 "
                      "--set side=48 --set mode=denoised --frames 3");
}

static void a_sun_lights_instances_and_leaves_alike(void **state)
{
    (void)state;
    agree("--scene builtin:chess --samples 200 --set side=256");
    agree("--scene builtin:plant --samples 200 --set side=256 --light sun:1,1,1");
}

static void a_board_with_holes_is_lit_alike(void **state)
{
    (void)state;
    need_masked();
    agree("--scene " MASKED " --samples 100 --set side=256 --light sun:0.3,0.9,0.2");
}

static void cloth_and_robots_in_motion_are_lit_alike(void **state)
{
    (void)state;
    agree("--scene builtin:cloth --samples 100 --set side=256 --light sun:1,2,1 --frames 2 --set pattern=equation3 "
          "--set noise=1");
    agree("--scene builtin:robots --samples 100 --set side=256 --light sun:1,2,1 --frames 2 --set pattern=poisson");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_emitter_in_a_room_lights_alike), cmocka_unit_test(light_of_a_spot_is_interpolated),
        cmocka_unit_test(lamps_denoised_over_frames_light_alike),
        cmocka_unit_test(a_sun_lights_instances_and_leaves_alike),
        cmocka_unit_test(a_board_with_holes_is_lit_alike), cmocka_unit_test(cloth_and_robots_in_motion_are_lit_alike)
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
