/* figure_test - a figure of another file in a scene, and a sun that goes on its way: what the options --figure and
   sun_turn of render make of a scene, by numbers, and pictures of both. */
#define _POSIX_C_SOURCE 200809L
#include "program.h"
#include "common.h"
#include <math.h>

#include "../../examples/render/setup.h"

enum { FIGURE };
static char walker[600];

typedef struct stage {
    rd_args     args;
    rd_job      job;
    ex_scene    scene;
    rd_emitter *emitters;
    char        error[EX_ERROR_SIZE];
} stage;

/* What render makes of these arguments, separated by spaces. */
static int open_stage(stage *s, const char *arguments, float time)
{
    static char text[2000];
    char *values[32] = { NULL };
    int count = 1;
    memset(s, 0, sizeof *s);
    snprintf(text, sizeof text, "--technique rsm --out x.pfm --size 16x16 %s", arguments);
    for (char *word = strtok(text, " "); word && count < 32; word = strtok(NULL, " ")) values[count++] = word;
    if (rd_args_parse(&s->args, count, values, s->error) != 0) return -1;
    return rd_setup(&s->scene, &s->job, &s->emitters, &s->args, time, s->error);
}

static void close_stage(stage *s)
{
    ex_scene_free(&s->scene);
    free(s->emitters);
    rd_args_free(&s->args);
}

static void must_open(stage *s, const char *arguments, float time)
{
    if (open_stage(s, arguments, time) == 0) return;
    if (strstr(s->error, "libtinygltf-dev")) skip();
    fail_msg("%s: %s", arguments, s->error);
}

static void must_move(stage *s, float time)
{
    if (rd_move(&s->scene, &s->job, &s->emitters, time, s->error) != 0) fail_msg("%s", s->error);
}

/* The file's own figure at a time, to the bit, a step to the side. */
static void compare_figure(const stage *s, float time)
{
    const ex_object *object = &s->scene.objects[s->scene.object_count - 1];
    const ex_mesh *mesh = &s->scene.meshes[object->mesh];
    char error[EX_ERROR_SIZE];
    ex_scene alone;
    ex_animation = 0;
    assert_int_equal(ex_scene_load(&alone, walker, error), 0);
    ex_animation = -1;
    assert_int_equal(ex_scene_set_time(&alone, time, error), 0);
    const ex_mesh *wanted = &alone.meshes[FIGURE];
    assert_int_equal(mesh->vertex_count, wanted->vertex_count);
    assert_int_equal(mesh->triangle_count, wanted->triangle_count);
    assert_memory_equal(mesh->positions, wanted->positions, 3 * sizeof(float) * (size_t)mesh->vertex_count);
    assert_memory_equal(mesh->normals, wanted->normals, 3 * sizeof(float) * (size_t)mesh->vertex_count);
    assert_memory_equal(mesh->indices, wanted->indices, 3 * sizeof(uint32_t) * (size_t)mesh->triangle_count);
    for (int k = 0; k < 3; k++)
        assert_true(fabsf(object->transform[12 + k] - alone.objects[FIGURE].transform[12 + k] -
                          s->args.figure_at[k]) < 1e-6f);
    for (uint32_t t = 0; t < mesh->triangle_count; t++)
        assert_memory_equal(s->scene.materials[mesh->materials[t]].base_color,
                            alone.materials[wanted->materials[t]].base_color, 3 * sizeof(float));
    ex_scene_free(&alone);
}

static void a_figure_walks_in_another_scene_without_its_room(void **state)
{
    char arguments[1400];
    stage s, bare;
    (void)state;
    must_open(&bare, "--scene builtin:cornell", 0);
    snprintf(arguments, sizeof arguments, "--scene builtin:cornell --figure %s@0.5,0,-0.25", walker);
    must_open(&s, arguments, 0.3f);
    assert_int_equal(s.scene.object_count, bare.scene.object_count + 1);
    assert_int_equal(s.scene.mesh_count, bare.scene.mesh_count + 1);
    assert_int_equal(s.scene.light_count, bare.scene.light_count);
    assert_memory_equal(&s.scene.camera, &bare.scene.camera, sizeof s.scene.camera);
    assert_true(s.scene.animated && !bare.scene.animated);
    assert_true(s.scene.meshes[s.scene.mesh_count - 1].deforms);
    compare_figure(&s, 0.3f);
    must_move(&s, 1.7f);
    compare_figure(&s, 1.7f);
    close_stage(&s);
    close_stage(&bare);
    snprintf(arguments, sizeof arguments, "--scene builtin:atrium --figure %s --set still=1", walker);
    must_open(&s, arguments, 0.5f);
    compare_figure(&s, 0.5f);
    must_move(&s, 1.7f);
    compare_figure(&s, 0.5f);
    close_stage(&s);
    snprintf(arguments, sizeof arguments, "--scene %s --figure %s@3,0,0", walker, walker);      /* two of them */
    must_open(&s, arguments, 0.7f);
    assert_int_equal(s.scene.object_count, 3);
    compare_figure(&s, 0.7f);
    close_stage(&s);
}

static void a_figure_that_cannot_be_added_is_refused(void **state)
{
    static const struct { const char *text, *says; } trials[] = {
        { "--scene builtin:cornell --figure nowhere.glb", "nowhere.glb" },
        { "--scene builtin:cornell --figure builtin:figure", "must be FILE.glb or FILE.gltf" },
        { "--scene builtin:cornell --figure a.glb@1,2", "behind @ three numbers are expected" },
        { "--scene builtin:cornell --figure a.glb@1,2,1e12", "behind @ three numbers are expected" },
        { "--scene builtin:cornell --set sun_turn=15", "sun_turn: the scene has no sun" },
    };
    stage s;
    (void)state;
    for (size_t i = 0; i < sizeof trials / sizeof trials[0]; i++) {
        assert_int_equal(open_stage(&s, trials[i].text, 0), -1);
        if (strstr(s.error, "libtinygltf-dev")) skip();
        if (!strstr(s.error, trials[i].says)) fail_msg("%s: %s", trials[i].text, s.error);
        rd_args_free(&s.args);
    }
}

/* ---- the sun ---- */

static void compare_sun(const stage *s, float x, float y, float z)
{
    const float *d = s->scene.lights[0].direction;
    if (!(fabsf(d[0] - x) < 1e-5f && fabsf(d[1] - y) < 1e-5f && fabsf(d[2] - z) < 1e-5f))
        fail_msg("the sun stands at %.5f, %.5f, %.5f, not at %.5f, %.5f, %.5f", (double)d[0], (double)d[1],
                 (double)d[2], (double)x, (double)y, (double)z);
}

/* On the day of equal night it rises in the east, stands 45 degrees high in the south, and sets in the west. On a day
   in summer its height at noon is more by as much as it stands north of the equator. */
static void the_sun_goes_from_east_over_south_to_west(void **state)
{
    const float half = 0.70710678f;
    stage s;
    (void)state;
    must_open(&s, "--scene builtin:plant --light sun:1,0,0,2 --set sun_turn=15", 0);
    assert_true(s.scene.animated);
    must_move(&s, 6);
    compare_sun(&s, 0, half, half);
    assert_true(s.scene.lights[0].value[0] > 1.99f);
    must_move(&s, 3);
    compare_sun(&s, half, 0.5f, 0.5f);
    must_move(&s, 9);
    compare_sun(&s, -half, 0.5f, 0.5f);
    must_move(&s, 12.1f);
    assert_true(s.scene.lights[0].direction[0] < -0.99f && s.scene.lights[0].direction[1] < 0);
    assert_true(!(s.scene.lights[0].value[0] > 0));
    must_move(&s, 24 + 6);
    compare_sun(&s, 0, half, half);
    assert_true(s.scene.lights[0].value[0] > 1.99f);
    close_stage(&s);
    must_open(&s, "--scene builtin:plant --light sun:-1,0,0,2 --set sun_turn=-15 --set still=1", 0);   /* backwards */
    must_move(&s, 6);
    compare_sun(&s, 0, half, half);
    close_stage(&s);
    must_open(&s, "--scene builtin:plant --light sun:0,0.9063078,0.4226183 --set sun_turn=15", 3);   /* 65 degrees */
    must_move(&s, 0);
    compare_sun(&s, 0, 0.9063078f, 0.4226183f);
    must_move(&s, 12);          /* midnight: 25 degrees below the northern horizon */
    compare_sun(&s, 0, -0.4226183f, -0.9063078f);
    close_stage(&s);
}

/* ---- pictures ---- */

static void render_to(ex_image *image, const char *arguments)
{
    char all[900], path[700], error[EX_ERROR_SIZE];
    if (snprintf(all, sizeof all, "%s --out a.pfm", arguments) >= (int)sizeof all) fail_msg("too long: %s", arguments);
    if (run("render", all) != 0) {
        if (strstr(output, "libtinygltf-dev")) skip();
        fail_msg("render %s: %s", all, output);
    }
    snprintf(path, sizeof path, "%s/a.pfm", folder);
    assert_int_equal(ex_image_read_pfm(image, path, error), 0);
}

/* Seen from above, east to the right: how far to the right of the middle the dark ground lies on average, in pixels. */
static double shadow_at(float time)
{
    char arguments[400];
    double dark = 0, sum = 0, bright = 0;
    ex_image image;
    snprintf(arguments, sizeof arguments, "--technique rsm --scene builtin:plant --set only=direct --set ground=1 "
             "--light sun:0.9,0.44,0.1 --set sun_turn=15 --camera 0,6,0.01,0,0,0,50 --size 64x64 --time %g",
             (double)time);
    render_to(&image, arguments);
    for (size_t i = 0; i < 64 * 64; i++) bright = fmax(bright, (double)image.rgb[3 * i]);
    for (size_t i = 0; i < 64 * 64; i++)
        if ((double)image.rgb[3 * i] < 0.05 * bright) {
            sum += (double)(i % 64) - 31.5;
            dark++;
        }
    ex_image_free(&image);
    assert_true(dark > 20);
    return sum / dark;
}

static void shadows_lie_in_the_west_in_the_morning_and_in_the_east_in_the_evening(void **state)
{
    (void)state;
    const double morning = shadow_at(0), evening = shadow_at(8);
    printf("dark ground lies at %.1f pixels in the morning, at %.1f in the evening\n", morning, evening);
    assert_true(morning < -2 && evening > 2);
}

/* The figure changes its part of the picture and no other, and is elsewhere a second later. ism keeps pictures of lamps
   where nothing moves, with the same bytes. */
static void it_is_drawn_where_it_walks(void **state)
{
    static const char *const whole = "--technique rsm --scene builtin:atrium --set only=direct --set side=512 "
                                     "--set still=1 --camera -6,1.7,1,-3,0.8,-2.2,50 --size 64x48";
    char arguments[1000];
    ex_image bare, one, other;
    size_t changed = 0, moved = 0;
    (void)state;
    render_to(&bare, whole);
    snprintf(arguments, sizeof arguments, "%s --figure %s@-3.4,0,-2.2", whole, walker);
    render_to(&one, arguments);
    snprintf(arguments, sizeof arguments, "%s --figure %s@-3.4,0,-2.2 --time 1", whole, walker);
    render_to(&other, arguments);
    for (size_t i = 0; i < 64 * 48; i++) {
        changed += memcmp(one.rgb + 3 * i, bare.rgb + 3 * i, 3 * sizeof(float)) != 0;
        moved += memcmp(one.rgb + 3 * i, other.rgb + 3 * i, 3 * sizeof(float)) != 0;
    }
    printf("%zu pixels of %d show the figure or its shadow, %zu change in a second\n", changed, 64 * 48, moved);
    assert_true(changed > 40 && changed < 900);
    assert_true(moved > 60 && moved < 1200);
    ex_image_free(&bare);
    ex_image_free(&one);
    ex_image_free(&other);
}

static void pictures_of_lamps_are_kept_where_nothing_moved(void **state)
{
    static const char *const sun = "--technique ism --scene builtin:uroom --size 48x32 --frames 3 --set rsm_side=64 "
                                   "--set vpl_count=64 --set surfel_count=500 --set shadow_map_side=64";
    char arguments[1000];
    ex_image a, b;
    (void)state;
    snprintf(arguments, sizeof arguments, "%s --json -", sun);
    render_to(&a, arguments);
    assert_true(number("maps") >= 1);
    assert_int_equal((int)number("kept_maps"), 0);
    snprintf(arguments, sizeof arguments, "%s --set keep=1 --json -", sun);
    render_to(&b, arguments);
    assert_int_equal((int)number("kept_maps"), (int)number("maps"));
    assert_memory_equal(a.rgb, b.rgb, 3 * 48 * 32 * sizeof(float));
    ex_image_free(&a);
    ex_image_free(&b);
    /* one lamp of a scene that stands still moves, then all of the scene */
    snprintf(arguments, sizeof arguments, "%s --set keep=1 --set sun_turn=15 --light sun:0.3,0.9,0.2 --json -", sun);
    render_to(&a, arguments);
    assert_true(number("kept_maps") >= 1 && number("kept_maps") < number("maps"));
    snprintf(arguments, sizeof arguments, "%s --set sun_turn=15 --light sun:0.3,0.9,0.2", sun);
    render_to(&b, arguments);
    assert_memory_equal(a.rgb, b.rgb, 3 * 48 * 32 * sizeof(float));
    ex_image_free(&a);
    ex_image_free(&b);
    snprintf(arguments, sizeof arguments, "--technique ism --scene builtin:robots --size 48x32 --frames 2 "
             "--set rsm_side=64 --set vpl_count=64 --set surfel_count=500 --set shadow_map_side=64 "
             "--set light_point_count=2 --set keep=1 --json -");
    render_to(&a, arguments);
    assert_int_equal((int)number("kept_maps"), 0);
    ex_image_free(&a);
}

static int begin(void **state)
{
    return built_file("walker.glb", walker, sizeof walker) == 0 ? open_folder(state) : -1;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_figure_walks_in_another_scene_without_its_room),
        cmocka_unit_test(a_figure_that_cannot_be_added_is_refused),
        cmocka_unit_test(the_sun_goes_from_east_over_south_to_west),
        cmocka_unit_test(shadows_lie_in_the_west_in_the_morning_and_in_the_east_in_the_evening),
        cmocka_unit_test(it_is_drawn_where_it_walks),
        cmocka_unit_test(pictures_of_lamps_are_kept_where_nothing_moved),
    };
    return cmocka_run_group_tests(tests, begin, close_folder);
}
