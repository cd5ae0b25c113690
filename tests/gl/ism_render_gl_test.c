/* ism_render_gl_test - `render --technique ism --backend gl` as a user calls it: the same VPLs and points as --backend
   cpu, so that the pictures agree far within the 2 % relative RMSE that are promised. */
#define _POSIX_C_SOURCE 200809L
#include "program.h"

static void agree(const char *scene)
{
    compare_back_ends("ism --size 48x36 --set vpls=64 --set points=256 --set tile=32 --set rsm=32 --set shadow=128",
                      0.02, scene);
}

static void emitter_in_a_room(void **state)
{
    (void)state;
    agree("--scene builtin:cornell --set near=sphere");
}

static void leaves_with_holes_under_a_sky(void **state)
{
    (void)state;
    agree("--scene builtin:plant --env builtin:sky --samples 64");
}

static void instances_and_lamps(void **state)
{
    (void)state;
    agree("--scene builtin:chess --light sun:1,1,1,2 --light sphere:2,2.5,1,0.4,6 --light spot:0,4,1,0,-1,-0.2,200");
}

static void two_bounces_round_a_corner(void **state)
{
    (void)state;
    agree("--scene builtin:uroom --set bounces=2 --set projection=lobe");
}

static void moving_cloth(void **state)
{
    (void)state;
    agree("--scene builtin:cloth --frames 3 --set lazy=2");
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
