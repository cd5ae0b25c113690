/* envshadow_render_gl_test - `render --technique envshadow --backend gl` as a user calls it: the picture of --backend
   cpu within 1 % relative RMSE, for instances, motion, holes of alpha masks, clusters, channels, a sun and every
   filter. */
#define _POSIX_C_SOURCE 200809L
#include "program.h"
#include "masked.h"
#include "room.h"

static void agree(const char *scene)
{
    compare_back_ends("envshadow --size 64x48", 0.01, scene);
}

static void instances_by_the_penumbra_filter_are_lit_alike(void **state)
{
    (void)state;
    agree("--scene builtin:chess --set light_count=16 --set map_side=128");
}

static void cloth_in_motion_in_clusters_is_lit_alike(void **state)
{
    (void)state;
    agree("--scene builtin:cloth --frames 3 --set light_count=30 --set capacity=7 --set filter=smooth");
}

static void times_of_a_frame_choose_the_clusters(void **state)
{
    (void)state;
    agree("--scene builtin:cloth --frames 2 --set light_count=100 --set map_side=64 --set capacity=auto");
    assert_int_equal(run("render", "--technique envshadow --backend gl --scene builtin:cloth --size 32x24 "
                         "--set light_count=100 --set map_side=64 --set capacity=auto --out x.pfm --json -"), 0);
    assert_true(number("capacity") >= 1 && number("capacity") <= 64);
}

static void an_explosion_under_a_sun_in_channels_is_lit_alike(void **state)
{
    (void)state;
    agree("--scene builtin:explosion --frames 3 --light sun:1,1,0.4,2 --env builtin:studio "
                      "--set emitters=0 --set light_count=14 --set rgba=1 --set map_side=200 --samples 1");
}

static void leaves_of_one_triangle_layer_by_pcf_are_lit_alike(void **state)
{
    (void)state;
    agree("--scene builtin:plant --set light_count=40 --set filter=pcf --env builtin:sky --set env_rotation=70");
}

static void a_board_with_holes_is_lit_alike(void **state)
{
    (void)state;
    need_masked();
    agree("--scene " MASKED " --set light_count=40 --set filter=pcf --env builtin:sky --light sun:0.3,0.9,0.2");
}

static void a_sky_through_a_window_lights_alike(void **state)
{
    (void)state;
    room_need();
    room_write("\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":1}}");
    agree("--scene room.gltf --env builtin:uniform --light sun:0.25,0.6,-0.75,2 --set light_count=100 "
          "--set map_side=128");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(instances_by_the_penumbra_filter_are_lit_alike),
        cmocka_unit_test(cloth_in_motion_in_clusters_is_lit_alike),
        cmocka_unit_test(times_of_a_frame_choose_the_clusters),
        cmocka_unit_test(an_explosion_under_a_sun_in_channels_is_lit_alike),
        cmocka_unit_test(leaves_of_one_triangle_layer_by_pcf_are_lit_alike),
        cmocka_unit_test(a_board_with_holes_is_lit_alike), cmocka_unit_test(a_sky_through_a_window_lights_alike)
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
