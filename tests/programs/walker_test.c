/* walker_test.c - the figure that tools/assets/walker.c makes: how it walks, by its vertices; and render's pictures of
   a file that moves. */
#define _POSIX_C_SOURCE 200809L
#include "program.h"
#include "common.h"
#include <math.h>

enum { FIGURE, ROOM };
static const float lap = 6.6f;
static char walker[600];

static void load(ex_scene *scene)
{
    char error[EX_ERROR_SIZE];
    ex_animation = 0;
    const int result = ex_scene_load(scene, walker, error);
    ex_animation = -1;
    if (result == 0) return;
    if (strstr(error, "libtinygltf-dev")) skip();
    fail_msg("%s", error);
}

static void at_time(ex_scene *scene, float time)
{
    char error[EX_ERROR_SIZE];
    if (ex_scene_set_time(scene, time, error) != 0) fail_msg("%s", error);
}

/* Signed, by the triangles' tetrahedra with the origin: that of a closed surface. */
static double volume_of(const ex_mesh *mesh)
{
    double sum = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const float *p[3];
        double d[3][3];
        for (int k = 0; k < 3; k++) {
            p[k] = mesh->positions + 3 * (size_t)mesh->indices[3 * t + (size_t)k];
            for (int i = 0; i < 3; i++) d[k][i] = (double)p[k][i];
        }
        for (int i = 0; i < 3; i++)
            sum += d[0][i] * (d[1][(i + 1) % 3] * d[2][(i + 2) % 3] - d[1][(i + 2) % 3] * d[2][(i + 1) % 3]) / 6;
    }
    return sum;
}

static void the_figure_is_closed_skinned_and_the_only_thing_that_deforms(void **state)
{
    ex_scene scene;
    (void)state;
    load(&scene);
    assert_true(scene.animated && scene.has_camera);
    assert_int_equal(scene.object_count, 2);
    assert_int_equal(scene.skipped_triangles, 0);
    assert_true(scene.meshes[FIGURE].deforms && !scene.meshes[ROOM].deforms);
    assert_true(scene.meshes[FIGURE].triangle_count > 20000);
    const double volume = volume_of(&scene.meshes[FIGURE]);      /* of a slender person, in cubic metres */
    assert_true(volume > 0.04 && volume < 0.09);
    ex_scene_free(&scene);
}

/* Round a circle of one metre, on the ground, upright, and as much of it as before: bones do not tear or crush it. */
static void it_walks_round_on_the_ground(void **state)
{
    ex_scene scene;
    (void)state;
    load(&scene);
    const ex_mesh *mesh = &scene.meshes[FIGURE];
    const double volume = volume_of(mesh);
    for (int step = 0; step < 40; step++) {
        const double angle = 6.283185307 * step / 40;
        double low = 1e9, high = -1e9, middle[2] = {0, 0};
        at_time(&scene, lap * (float)step / 40);
        for (size_t i = 0; i < mesh->vertex_count; i++) {
            const float *p = mesh->positions + 3 * i;
            low = fmin(low, (double)p[1]);
            high = fmax(high, (double)p[1]);
            middle[0] += (double)p[0] / mesh->vertex_count;
            middle[1] += (double)p[2] / mesh->vertex_count;
        }
        if (low < -0.03 || low > 0.03 || high < 1.65 || high > 1.80) fail_msg("step %d: %.3f to %.3f", step, low, high);
        assert_true(hypot(middle[0] - cos(angle), middle[1] - sin(angle)) < 0.12);
        const double now = volume_of(mesh);
        if (fabs(now / volume - 1) > 0.06) fail_msg("step %d: %.4f of the volume", step, now / volume);
    }
    ex_scene_free(&scene);
}

/* In a hundredth of a second the body goes a centimetre. The sole that it stands on turns with the body about the
   circle, and rolls over the toes, so it slides a third of that; a foot that is not moved back slides all of it. */
static void the_foot_it_stands_on_stays_behind(void **state)
{
    ex_scene scene;
    (void)state;
    load(&scene);
    const ex_mesh *mesh = &scene.meshes[FIGURE];
    float *before = malloc(3 * (size_t)mesh->vertex_count * sizeof *before);
    double slid = 0;
    size_t count = 0;
    assert_non_null(before);
    for (int step = 0; step < 22; step++) {
        at_time(&scene, 0.05f * (float)step);
        memcpy(before, mesh->positions, 3 * (size_t)mesh->vertex_count * sizeof *before);
        at_time(&scene, 0.05f * (float)step + 0.01f);
        for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i += 3)
            if (before[i + 1] < 0.012f && mesh->positions[i + 1] < 0.012f) {
                slid += hypot((double)(mesh->positions[i] - before[i]),
                              (double)(mesh->positions[i + 2] - before[i + 2]));
                count++;
            }
    }
    printf("soles slide %.4f of the way\n", slid / (double)count / (0.01 * 6.283185307 / (double)lap));
    assert_true(count > 500 && slid / (double)count < 0.45 * 0.01 * 6.283185307 / (double)lap);
    free(before);
    ex_scene_free(&scene);
}

/* Half a lap is three cycles: the same figure on the other side, turned about. A quarter breathes in. */
static void half_a_lap_is_the_same_figure_turned_about(void **state)
{
    ex_scene one, other;
    (void)state;
    load(&one);
    load(&other);
    at_time(&one, 0.2f);
    at_time(&other, 0.2f + 0.5f * lap);
    const ex_mesh *a = &one.meshes[FIGURE], *b = &other.meshes[FIGURE];
    double off = 0;
    for (size_t i = 0; i < 3 * (size_t)a->vertex_count; i += 3) {
        if (a->positions[i + 1] > 1.30f) continue;               /* but for the head, which looks elsewhere */
        for (size_t k = 0; k < 3; k++) {
            const float sign = k == 1 ? 1.0f : -1.0f;
            off = fmax(off, (double)fabsf(a->positions[i + k] - sign * b->positions[i + k]));
            off = fmax(off, 0.1 * (double)fabsf(a->normals[i + k] - sign * b->normals[i + k]));
        }
    }
    ex_scene_free(&one);
    ex_scene_free(&other);
    if (off > 1e-4) fail_msg("%g", off);
}

/* ---- render ---- */

static double difference(const char *a, const char *b)
{
    char arguments[100];
    snprintf(arguments, sizeof arguments, "%s %s", a, b);
    if (run("compare", arguments) != 0) fail_msg("compare: %s", output);
    return number("relative_rmse");
}

/* The fourth frame from 0.3 s on is what 0.4 s show; ism's has other VPLs, since it keeps some of the frames before. */
static void frames_and_time_play_a_file(void **state)
{
    static const char *const ways[] = {
        "rsm --samples 64",
        "ism --set vpl_count=64 --set surfel_count=1000 --set rsm_side=64 --set shadow_map_side=128",
        "envshadow --set light_count=8 --samples 1"
    };
    (void)state;
    for (int i = 0; i < 3; i++) {
        static const char *const times[3] = {"--time 0.3 --frames 4", "--time 0.4 --seed 3",
                                              "--time 0.3 --frames 4 --set still=1"};
        for (int k = 0; k < 3; k++) {
            char arguments[900];
            snprintf(arguments, sizeof arguments, "--technique %s --scene %s --size 64x48 %s --out %d.pfm", ways[i],
                     walker, times[k], k);
            run("render", arguments);
            if (strstr(output, "libtinygltf-dev")) skip();
            expect(0, "", arguments);
        }
        const double same = difference("0.pfm", "1.pfm"), stood = difference("2.pfm", "1.pfm");
        printf("%s: %.5f beside the same time, %.3f beside 0.1 s before\n", ways[i], same, stood);
        assert_true(same < 0.4 * stood && stood > 0.05);
    }
}

static void opengl_lights_it_alike(void **state)
{
    char scene[700];
    (void)state;
    snprintf(scene, sizeof scene, "--scene %s --size 64x48 --time 0.3 --frames 3", walker);
    ex_scene loaded;
    load(&loaded);
    ex_scene_free(&loaded);
    compare_back_ends("rsm --samples 64 --set side=64", 0.01, scene);
    compare_back_ends("envshadow --set light_count=8", 0.03, scene);
    compare_back_ends("ism --set vpl_count=64 --set surfel_count=1000 --set rsm_side=64 --set shadow_map_side=128",
                      0.03, scene);
}

/* The sun grazes the grey wall, which nothing shadows: no texel of the shadow map may shadow it either. */
static void a_grazed_wall_has_no_moire(void **state)
{
    char arguments[900], path[700], error[EX_ERROR_SIZE];
    ex_image image;
    float worst = 0;
    (void)state;
    snprintf(arguments, sizeof arguments, "--technique ism --scene %s --size 200x112 --samples 1 --time 0.4 "
             "--set vpl_count=16 --set surfel_count=500 --out wall.pfm", walker);
    run("render", arguments);
    if (strstr(output, "libtinygltf-dev")) skip();
    expect(0, "", arguments);
    snprintf(path, sizeof path, "%s/wall.pfm", folder);
    assert_int_equal(ex_image_read_pfm(&image, path, error), 0);
    for (size_t y = 15; y < 55; y++)
        for (size_t x = 140; x < 195; x++) {
            const float *a = image.rgb + 3 * (y * 200 + x), *b = a + 3;
            worst = fmaxf(worst, fabsf(a[0] - b[0]) / fmaxf(a[0], b[0]));
        }
    printf("neighbours on the wall differ by %.4f\n", (double)worst);
    assert_true(worst < 0.02f);     /* 0.17 with a plane that is followed three texels far */
    ex_image_free(&image);
}

/* One surface is one piece, of which cuts across would make two bones; joints make one or more each. */
static void its_joints_are_bones_of_shadow_fields(void **state)
{
    char arguments[900];
    ex_scene scene;
    (void)state;
    load(&scene);
    assert_non_null(scene.meshes[FIGURE].parts);
    ex_scene_free(&scene);
    snprintf(arguments, sizeof arguments, "--technique shadowfield --set bones=1 --set position_side=2 "
             "--set shell_count=2 --set point_spacing=0.5 --env builtin:uniform --size 64x48 --scene %s --frames 2 --out a.pfm --json -", walker);
    expect(0, "\"bones\": ", arguments);
    assert_true(number("bones") >= 16 && number("bones") < 64);
}

static void an_animation_that_is_not_there_is_refused(void **state)
{
    char arguments[900];
    (void)state;
    snprintf(arguments, sizeof arguments, "--technique rsm --scene %s --set animation=1 --out a.pfm", walker);
    run("render", arguments);
    if (strstr(output, "libtinygltf-dev")) skip();
    expect(1, "animation 1 does not exist, it has 1", arguments);
}

static int begin(void **state)
{
    return built_file("walker.glb", walker, sizeof walker) == 0 ? open_folder(state) : -1;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_figure_is_closed_skinned_and_the_only_thing_that_deforms),
        cmocka_unit_test(it_walks_round_on_the_ground),
        cmocka_unit_test(the_foot_it_stands_on_stays_behind),
        cmocka_unit_test(half_a_lap_is_the_same_figure_turned_about),
        cmocka_unit_test(frames_and_time_play_a_file),
        cmocka_unit_test(opengl_lights_it_alike),
        cmocka_unit_test(a_grazed_wall_has_no_moire),
        cmocka_unit_test(its_joints_are_bones_of_shadow_fields),
        cmocka_unit_test(an_animation_that_is_not_there_is_refused),
    };
    return cmocka_run_group_tests(tests, begin, close_folder);
}
