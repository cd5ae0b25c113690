/* visible_test - shadows of bounced light by rsm_gather_desc.visible_fn: a light counts as much as the function says of
   its number, which is that of rsm_pixel_lights or of the list; the function is asked about nothing else. */

#include "rsm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include "util.h"

enum { WIDTH = 12, HEIGHT = 9, POINTS = WIDTH * HEIGHT, SIDE = 20, MOST = 2 * SIDE * SIDE, SAMPLES = 150 };

static float positions[3 * POINTS], normals[3 * POINTS];

/* Two suns on a floor and a wall of two meshes; the second map has a Phong lobe on its wall. */
static rsm_map *maps[2];
static model floor_of, wall_of;

static int make_scene(void **state)
{
    static const float floor_quad[9] = { -2, 0, -2, 0, 0, 4, 4, 0, 0 }, wall_quad[9] = { -2, 0, -2, 4, 0, 0, 0, 3, 0 };
    (void)state;
    floor_of = model_quads(floor_quad, 1);
    wall_of = model_quads(wall_quad, 1);
    for (int i = 0; i < 2; i++) {
        rsm_desc d = sun_desc(10, 2.5, SIDE);
        rsm_mesh meshes[2];
        meshes[0] = mesh_of(&floor_of, 0.5);
        meshes[1] = mesh_of(&wall_of, i ? 0.0 : 0.8);
        meshes[1].material = 1;
        set3(d.light.direction, 0.2, 1, i ? 1 : 0.3);
        maps[i] = map_of(&d, meshes, 2, NULL);
    }
    for (int i = 0; i < POINTS; i++) {
        double a = 0.7 * i, y = 0.1 + 0.02 * i;
        set3(positions + 3 * i, 1.5 * cos(a), y, 1.2 * sin(1.3 * a));
        set3(normals + 3 * i, 0.6 * cos(3 * a), -0.8, 0.6 * sin(3 * a));
    }
    return 0;
}

static int free_scene(void **state)
{
    (void)state;
    rsm_map_free(maps[0]);
    rsm_map_free(maps[1]);
    model_free(&floor_of);
    model_free(&wall_of);
    return 0;
}

/* What the function says of a number, and what it was asked. */
typedef struct seer { int turned; uint32_t lights; size_t asked, most; uint8_t heard[MOST]; } seer;

static float share_of(uint32_t number) { return (float)((number * 2654435769u) >> 24) / 255.0f; }

static void see(void *user, const float position[3], const float normal[3], const uint32_t *numbers, size_t count,
                float *visible)
{
    seer *s = (seer *)user;
    int at = 0;
    assert_true(count >= 1 && count <= 64);
    while (at < POINTS && (memcmp(position, positions + 3 * at, 12) || memcmp(normal, normals + 3 * at, 12))) at++;
    assert_true(at < POINTS);
    for (size_t i = 0; i < count; i++) {
        assert_true(numbers[i] < s->lights);
        s->heard[numbers[i]] = 1;
        visible[i] = s->turned ? 1 - share_of(numbers[i]) : share_of(numbers[i]);
    }
    s->asked += count;
    if (count > s->most) s->most = count;
}

static seer seer_of(uint32_t lights, int turned)
{
    seer s;
    memset(&s, 0, sizeof s);
    s.lights = lights;
    s.turned = turned;
    return s;
}

static void alike(const float *a, const float *b, size_t count, double relative)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) sum += fabs((double)b[i]);
    assert_true(sum > 0);
    for (size_t i = 0; i < count; i++)
        if (!(fabs((double)a[i] - (double)b[i]) <= relative * (fabs((double)b[i]) + sum / (double)count)))
            fail_msg("%zu: %.9g, not %.9g", i, (double)a[i], (double)b[i]);
}

/* Every light of the list alone, times its share, summed in double. */
static void add_up(const rsm_texel *lights, size_t count, const rsm_points *points, float *out)
{
    static double sum[3 * POINTS];
    static float one[3 * POINTS];
    memset(sum, 0, sizeof sum);
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(rsm_gather_list(lights + i, 1, NULL, points, one, NULL), RSM_OK);
        for (int k = 0; k < 3 * POINTS; k++) sum[k] += (double)one[k] * (double)share_of((uint32_t)i);
    }
    for (int k = 0; k < 3 * POINTS; k++) out[k] = (float)sum[k];
}

static void a_light_counts_by_the_visibility_of_its_own_number(void **state)
{
    static rsm_texel lights[MOST];
    static float expected[3 * POINTS], got[3 * POINTS];
    rsm_points points = points_of(positions, normals, POINTS, WIDTH);
    (void)state;
    for (uint32_t samples = 0; samples <= SAMPLES; samples += SAMPLES) {
        rsm_gather_desc d = gather_desc(RSM_PATTERN_FLUX, samples);
        size_t count = 0;
        seer s;
        d.seed = 5;
        assert_int_equal(rsm_pixel_lights((const rsm_map *const *)maps, 2, samples, 5, lights, MOST, &count), RSM_OK);
        assert_true(count > 100);
        add_up(lights, count, &points, expected);
        s = seer_of((uint32_t)count, 0);
        d.visible_fn = see;
        d.visible_user = &s;
        assert_int_equal(rsm_gather_list(lights, count, &d, &points, got, NULL), RSM_OK);
        alike(got, expected, 3 * POINTS, 1e-5);
        assert_true(s.most == 64 && s.asked < count * POINTS);
        assert_int_equal(rsm_gather((const rsm_map *const *)maps, 2, &d, &points, got, NULL), RSM_OK);
        alike(got, expected, 3 * POINTS, 1e-5);
        for (size_t i = 0; i < count; i++) assert_true(s.heard[i]);
        d.near_field = 0.05f;                   /* too small for any receiver to be near a texel */
        assert_int_equal(rsm_gather((const rsm_map *const *)maps, 2, &d, &points, got, NULL), RSM_OK);
        alike(got, expected, 3 * POINTS, 1e-5);
    }
}

/* What the function hides and what it lets through are all that is there, for every way in which lights are shared. */
static void what_is_hidden_and_what_is_seen_are_the_whole(void **state)
{
    static float open[3 * POINTS], part[3 * POINTS];
    rsm_points points = points_of(positions, normals, POINTS, WIDTH);
    const rsm_material lobe = { { 0.3f, 0.3f, 0.3f }, 9 };
    (void)state;
    for (int way = 0; way < 32; way++) {
        rsm_gather_desc d = gather_desc(RSM_PATTERN_FLUX, way & 1 ? SAMPLES : 0);
        rsm_gather_stats stats;
        size_t count = 0;
        seer s;
        assert_int_equal(rsm_pixel_lights((const rsm_map *const *)maps, 2, d.sample_count, 0, NULL, 0, &count),
                         RSM_ERR_MEMORY);
        d.interleave = way & 2 ? 2 : 1;
        d.near_field = way & 4 ? 3 : 0;
        if (way & 8) {
            d.materials = &lobe;
            d.material_count = 1;
        }
        d.near_limit = way & 16 ? 0.05f : 0;
        /* The second map's wall is black, with a lobe: texels that have no number. So this map is asked without it. */
        assert_int_equal(rsm_gather((const rsm_map *const *)maps, way & 8 ? 1 : 2, &d, &points, open, NULL), RSM_OK);
        d.visible_fn = see;
        d.visible_user = &s;
        s = seer_of((uint32_t)count, 0);
        assert_int_equal(rsm_gather((const rsm_map *const *)maps, way & 8 ? 1 : 2, &d, &points, part, &stats), RSM_OK);
        assert_true((stats.clamped_share > 0) == (way >= 16) && stats.evaluated == POINTS);
        s = seer_of((uint32_t)count, 1);
        d.add = 1;
        assert_int_equal(rsm_gather((const rsm_map *const *)maps, way & 8 ? 1 : 2, &d, &points, part, NULL), RSM_OK);
        alike(part, open, 3 * POINTS, 1e-5);
        assert_true(s.asked > 0);
    }
}

/* A receiver near a texel takes it as a surface, which may reach over its horizon: asked about as well. */
static void near_texels_have_the_numbers_of_their_lights(void **state)
{
    static rsm_texel lights[MOST];
    float at[3] = { 0.03f, 0.02f, 0.04f }, up[3] = { 0, -1, 0 }, all[3], one[3];
    rsm_points points = points_of(at, up, 1, 0);
    rsm_gather_desc d = gather_desc(RSM_PATTERN_FLUX, 0);
    const rsm_map *map = maps[0];
    size_t count = 0, nearest = 0;
    double least = 1e9;
    (void)state;
    memcpy(positions, at, sizeof at);
    memcpy(normals, up, sizeof up);
    d.near_field = 3;
    assert_int_equal(rsm_pixel_lights(&map, 1, 0, 0, lights, MOST, &count), RSM_OK);
    for (size_t i = 0; i < count; i++) {
        double x = (double)(lights[i].position[0] - at[0]), y = (double)(lights[i].position[1] - at[1]),
               z = (double)(lights[i].position[2] - at[2]);
        if (x * x + y * y + z * z < least) {
            least = x * x + y * y + z * z;
            nearest = i;
        }
    }
    assert_int_equal(rsm_gather(&map, 1, &d, &points, all, NULL), RSM_OK);
    {
        seer s = seer_of((uint32_t)count, 0);
        d.visible_fn = see;
        d.visible_user = &s;
        assert_int_equal(rsm_gather(&map, 1, &d, &points, one, NULL), RSM_OK);
        assert_true(s.heard[nearest]);
    }
    /* The texel below fills most of the receiver's half space: its share is nearly that of all. */
    assert_true(fabs((double)one[1] / (double)all[1] - (double)share_of((uint32_t)nearest)) < 0.06);
}

static float answer;

static void say(void *user, const float position[3], const float normal[3], const uint32_t *numbers, size_t count,
                float *visible)
{
    (void)user, (void)position, (void)normal, (void)numbers;
    while (count--) visible[count] = answer;
}

static void answers_beyond_0_and_1_count_as_these(void **state)
{
    static float got[3 * POINTS], full[3 * POINTS];
    rsm_points points = points_of(positions, normals, POINTS, WIDTH);
    rsm_gather_desc d = gather_desc(RSM_PATTERN_FLUX, SAMPLES);
    (void)state;
    d.visible_fn = say;
    answer = 1;
    assert_int_equal(rsm_gather((const rsm_map *const *)maps, 2, &d, &points, full, NULL), RSM_OK);
    answer = 7;
    assert_int_equal(rsm_gather((const rsm_map *const *)maps, 2, &d, &points, got, NULL), RSM_OK);
    assert_memory_equal(got, full, sizeof got);
    memset(full, 0, sizeof full);
    for (int i = 0; i < 2; i++) {
        answer = i ? (float)NAN : -1.0f;
        assert_int_equal(rsm_gather((const rsm_map *const *)maps, 2, &d, &points, got, NULL), RSM_OK);
        for (int k = 0; k < 3 * POINTS; k++) assert_true(fabsf(got[k]) <= 0.0f);
    }
}

static void half_visible_lights_give_half_of_an_interpolated_picture(void **state)
{
    enum { SIZE = 32 };
    static float at[3 * SIZE * SIZE], up[3 * SIZE * SIZE], whole[3 * SIZE * SIZE], half[3 * SIZE * SIZE];
    rsm_points points = points_of(at, up, SIZE * SIZE, SIZE);
    rsm_gather_desc d = gather_desc(RSM_PATTERN_FLUX, SAMPLES);
    rsm_gather_stats stats;
    (void)state;
    for (int i = 0; i < SIZE * SIZE; i++) {
        set3(at + 3 * i, 0.05 * (i % SIZE) - 0.8, 2, 0.05 * (i / SIZE) - 0.8);
        set3(up + 3 * i, 0, -1, 0);
    }
    d.visible_fn = say;
    answer = 1;
    assert_int_equal(rsm_interpolate((const rsm_map *const *)maps, 2, &d, NULL, &points, whole, &stats), RSM_OK);
    assert_true(stats.evaluated < SIZE * SIZE / 4);
    answer = 0.5f;
    assert_int_equal(rsm_interpolate((const rsm_map *const *)maps, 2, &d, NULL, &points, half, NULL), RSM_OK);
    for (int k = 0; k < 3 * SIZE * SIZE; k++) assert_true(fabsf(half[k] - 0.5f * whole[k]) <= 0.0f);
}

static char last[300];

static void keep(void *user, const char *message)
{
    (void)user;
    strcpy(last, message);
}

static void lights_about_each_receiver_have_no_numbers(void **state)
{
    static float got[3 * POINTS];
    static rsm_texel light;
    rsm_points points = points_of(positions, normals, POINTS, WIDTH);
    rsm_gather_desc d = gather_desc(RSM_PATTERN_MIXED, 16);
    (void)state;
    d.visible_fn = say;
    d.system.log = keep;
    assert_int_equal(rsm_gather((const rsm_map *const *)maps, 2, &d, &points, got, NULL), RSM_ERR_DESC);
    assert_string_equal(last, "rsm_gather: desc.pattern is 6; it must be RSM_PATTERN_FLUX with visible_fn, unless "
                              "sample_count is 0");
    assert_int_equal(rsm_interpolate((const rsm_map *const *)maps, 2, &d, NULL, &points, got, NULL), RSM_ERR_DESC);
    light.normal[1] = 1;
    assert_int_equal(rsm_gather_list(&light, 1, &d, &points, got, NULL), RSM_OK);
    d.sample_count = 0;
    assert_int_equal(rsm_gather((const rsm_map *const *)maps, 2, &d, &points, got, NULL), RSM_OK);
}

static void failing_memory_leaves_the_output_and_leaks_nothing(void **state)
{
    static float got[3 * POINTS];
    rsm_texel light;
    rsm_points points = points_of(positions, normals, POINTS, WIDTH);
    rsm_gather_desc d = gather_desc(RSM_PATTERN_FLUX, 0);
    ledger l;
    (void)state;
    memset(&light, 0, sizeof light);
    light.normal[1] = 1;
    d.system = ledger_system(&l);
    d.visible_fn = say;
    for (int list = 0; list < 2; list++) {
        rsm_result result = RSM_ERR_ALLOC;
        for (int k = 1; result != RSM_OK; k++) {
            memset(&l, 0, sizeof l);
            l.fail_at = (size_t)k;
            got[0] = 42;
            result = list ? rsm_gather_list(&light, 1, &d, &points, got, NULL)
                          : rsm_gather((const rsm_map *const *)maps, 2, &d, &points, got, NULL);
            assert_true(result == RSM_OK || (result == RSM_ERR_ALLOC && fabsf(got[0] - 42) <= 0.0f));
            assert_int_equal(l.live, 0);
        }
        assert_true(l.calls >= 4);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_light_counts_by_the_visibility_of_its_own_number),
        cmocka_unit_test(what_is_hidden_and_what_is_seen_are_the_whole),
        cmocka_unit_test(near_texels_have_the_numbers_of_their_lights),
        cmocka_unit_test(answers_beyond_0_and_1_count_as_these),
        cmocka_unit_test(half_visible_lights_give_half_of_an_interpolated_picture),
        cmocka_unit_test(lights_about_each_receiver_have_no_numbers),
        cmocka_unit_test(failing_memory_leaves_the_output_and_leaks_nothing),
    };
    return cmocka_run_group_tests(tests, make_scene, free_scene);
}
