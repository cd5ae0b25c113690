/* sfield_render_gl_test - `render --technique shadowfield --backend gl` as a user calls it: the same points as --backend cpu,
   within 1 % relative RMSE. What is left of a difference: the CPU orders occluders for 16 points at a time, GL for each. */
#define _POSIX_C_SOURCE 200809L
#include "program.h"

static void agree(const char *scene)
{
    compare_back_ends("shadowfield --size 48x36", 0.01, scene);
}

/* Small fields: this is about agreement, not about quality. */
#define SMALL " --set position_side=2 --set shells=3 --set spacing=0.2"

static void sky_on_instances(void **state)
{
    (void)state;
    agree("--scene builtin:chess --frames 2" SMALL);
}

static void spots_and_sun_on_glossy_robots(void **state)
{
    (void)state;
    agree("--scene builtin:robots --set materials=full --set bands=3 --light sun:1,1,1,2" SMALL);
}

static void moving_video_light(void **state)
{
    (void)state;
    agree("--scene builtin:explosion --frames 2" SMALL);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(sky_on_instances), cmocka_unit_test(spots_and_sun_on_glossy_robots),
                                        cmocka_unit_test(moving_video_light) };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
