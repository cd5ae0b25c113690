/* sfield_render_test - `render --technique shadowfield` as a user calls it, where time passes: a video that shines beside the
   reference, meshes that deform, lamps that alone move. */
#define _POSIX_C_SOURCE 200809L
#include "program.h"

/* Small fields: this is about what follows the time, not about quality. */
#define SMALL " --set position_side=2 --set shells=3 --set spacing=0.1"

/* Where render kept the first frame's field, the mean was 1.37 at frame 8 (and 26 at frame 40). 0.15: frames 8 and 16
   with fields this small are off by 0.01 and 0.09, frame 40 with position_side=6 by 0.02. */
static void video_follows_time(void **state)
{
    static const char scene[] = "--scene builtin:explosion --size 64x36 --frames 8 --out";
    char line[400];
    (void)state;
    need_reference();
    snprintf(line, sizeof line, "--technique reference --samples 256 %s ref.pfm", scene);
    expect(0, "", line);
    snprintf(line, sizeof line, "--technique shadowfield %s a.pfm" SMALL " --set source_side=3 --set source_shells=6",
             scene);
    expect(0, "", line);
    assert_int_equal(run("compare", "a.pfm ref.pfm"), 0);
    printf("frame 8 of a blast: mean_ratio %.3f\n", number("mean_ratio"));
    assert_true(number("mean_ratio") > 0.85 && number("mean_ratio") < 1.15);
}

/* As it hangs at the start a cloth is a mesh like others; fields of another time would be wrong. */
static void deforming_meshes_are_refused(void **state)
{
    (void)state;
    expect(0, "", "--technique shadowfield --scene builtin:cloth --size 32x18 --out a.pfm" SMALL);
    expect(1, "shadowfield: object cloth deforms",
           "--technique shadowfield --scene builtin:cloth --size 32x18 --frames 2 --out a.pfm" SMALL);
}

/* Under a sky, while two lamps circle: what hides the lights is taken from the last frame, and the picture stays. */
static void lazy_frames_are_the_same(void **state)
{
    static const char scene[] = "--technique shadowfield --scene builtin:knot --set still=1 --env builtin:overcast "
                                "--size 32x18 --set position_side=2 --set shells=3 --set spacing=0.4";
    char line[400];
    (void)state;
    snprintf(line, sizeof line, "%s --set lamps=2 --frames 3 --out a.pfm", scene);
    expect(0, "", line);
    snprintf(line, sizeof line, "%s --set lamps=2 --out first.pfm", scene);
    expect(0, "", line);
    snprintf(line, sizeof line, "%s --set lamps=2 --frames 3 --set lazy=1 --out b.pfm --json -", scene);
    expect(0, "", line);
    printf("points times lights that were kept: %.0f of %.0f\n", number("reused"), 3 * number("points"));
    assert_true(number("reused") > 0.9 * 3 * number("points"));      /* a lamp may have passed the knot's middle */
    assert_true(number("cache_bytes") > 0);
    assert_int_equal(run("compare", "b.pfm a.pfm"), 0);
    assert_true(number("relative_rmse") < 1e-4);     /* of 16 bits, in which it is kept */
    assert_int_equal(run("compare", "a.pfm first.pfm"), 0);
    assert_true(number("relative_rmse") > 1e-3);
    snprintf(line, sizeof line, "%s --set lazy=1 --set materials=full --out a.pfm", scene);
    expect(1, "lazy=1 needs materials=diffuse", line);
}

static void baked_fields_are_used(void **state)
{
    static const char scene[] = "--technique shadowfield --scene builtin:knot --env builtin:overcast --size 32x18 "
                                "--set shells=3 --set spacing=0.4";
    char line[400];
    (void)state;
    if (run("bake", "shadowfield builtin:knot -o knot.sf --set shells=3 --set position_side=4") != 0)
        fail_msg("%s", output);
    snprintf(line, sizeof line, "%s --set position_side=4 --out built.pfm", scene);
    expect(0, "", line);
    snprintf(line, sizeof line, "%s --set position_side=2 --baked knot.sf --out baked.pfm", scene);
    expect(0, "", line);
    snprintf(line, sizeof line, "%s --set position_side=2 --out other.pfm", scene);
    expect(0, "", line);
    assert_int_equal(run("compare", "baked.pfm built.pfm"), 0);
    assert_true(number("relative_rmse") <= 0);
    assert_int_equal(run("compare", "other.pfm built.pfm"), 0);
    assert_true(number("relative_rmse") > 1e-4);
    snprintf(line, sizeof line, "%s --set bands=3 --baked knot.sf --out x.pfm", scene);
    expect(1, "these bands", line);
    expect(1, "another object", "--technique shadowfield --scene builtin:plant --size 32x18 --baked knot.sf --out x.pfm" SMALL);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(video_follows_time),
                                        cmocka_unit_test(deforming_meshes_are_refused),
                                        cmocka_unit_test(lazy_frames_are_the_same),
                                        cmocka_unit_test(baked_fields_are_used) };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
