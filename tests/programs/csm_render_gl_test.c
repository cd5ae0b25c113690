/* csm_render_gl_test - `render --technique csm --backend gl` as a user calls it: the same samples as --backend cpu,
   within 1 % relative RMSE, for every kind of light and material. The two differ by float rounding alone. And the
   Cornell box beside the reference, as programs/csm_render_test has it for the CPU. */
#define _POSIX_C_SOURCE 200809L
#define CONFORM_BACKEND "gl"
#include "conformance.h"
#include "program.h"

static void agree(const char *scene)
{
    compare_back_ends("csm --size 64x48", 0.01, scene);
}

static void a_sky_on_instances_lights_alike(void **state)
{
    (void)state;
    agree("--scene builtin:chess --samples 16 --set side=16 --set map_side=48 --set filter=pcf");
}

static void an_emitter_in_a_room_lights_alike(void **state)
{
    (void)state;
    agree("--scene builtin:cornell --samples 16 --set light_side=3 --set light_map_side=48");
}

static void sun_lamp_and_spot_light_glossy_leaves_alike(void **state)
{
    (void)state;
    agree("--scene builtin:plant --samples 16 --set materials=full --set light_side=3 --set light_map_side=48 "
          "--set hard_map_side=128 --light sun:1,1,1,2 --light sphere:2,2.5,1,0.4,6 --light spot:0,4,1,0,-1,-0.2,200");
}

static void cornell_matches_reference(void **state)
{
    (void)state;
    need_reference();
    render_or_skip("--technique csm --backend gl --scene builtin:cornell --size 96x72 --samples 256 --out gl.pfm");
    expect(0, "", "--technique reference --scene builtin:cornell --size 96x72 --samples 256 --out ref.pfm");
    assert_int_equal(run("compare", "gl.pfm ref.pfm"), 0);
    CONFORM_MAX("image", "Cornell box beside the reference, relative rmse", 0.03, number("relative_rmse"));
    CONFORM_MIN("image", "Cornell box beside the reference, ssim", 0.998, number("ssim"));
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(a_sky_on_instances_lights_alike),
                                        cmocka_unit_test(an_emitter_in_a_room_lights_alike),
                                        cmocka_unit_test(sun_lamp_and_spot_light_glossy_leaves_alike),
                                        cmocka_unit_test(cornell_matches_reference) };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
