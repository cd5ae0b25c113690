/* kept_test - rsm_redraw keeps a map whose light and meshes are what they were, and draws it anew when anything that it
   shows has changed: each time the map has the bytes of a map drawn fresh. */

#include "rsm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"

enum { SIDE = 16, BALL = 40000 };

static float floor_at[12] = { -2, 0, -2, -2, 0, 2, 2, 0, 2, 2, 0, -2 }, cloth[8 * 4];
static uint32_t floor_indices[6] = { 0, 1, 2, 0, 2, 3 };
static uint16_t cloth_indices[6] = { 0, 1, 2, 0, 2, 3 };
static float many[3 * BALL], turned[16];
static uint32_t bits;

static int mask(void *user, uint32_t triangle, const float weights[3])
{
    (void)triangle;
    return weights[0] + weights[1] < *(float *)user;
}

static float edge = 0.5f;

static void make(rsm_mesh meshes[3])
{
    memset(meshes, 0, 3 * sizeof *meshes);
    for (int i = 0; i < 4; i++) set3(cloth + 8 * i, i & 1 ? 1 : -1, 0.5, i & 2 ? 1 : -1);
    for (int i = 0; i < BALL; i++) {
        bits = bits * 1664525u + 1013904223u;
        set3(many + 3 * i, 0.001 * (bits >> 20) - 2, 0.2, 0.0007 * (i % 5000) - 1.7);
    }
    memset(turned, 0, sizeof turned);
    turned[0] = turned[5] = turned[10] = turned[15] = 1;
    meshes[0].positions = floor_at;
    meshes[0].vertex_count = 4;
    meshes[0].indices = floor_indices;
    meshes[0].index_count = 6;
    meshes[1].positions = cloth;
    meshes[1].vertex_count = 4;
    meshes[1].vertex_stride = 32;
    meshes[1].indices16 = cloth_indices;
    meshes[1].index_count = 6;
    meshes[1].transform = turned;
    meshes[2].positions = many;                 /* two pieces of tasks; no indices */
    meshes[2].vertex_count = BALL - 1;
    for (int i = 0; i < 3; i++) set3(meshes[i].albedo, 0.5, 0.4, 0.3);
    meshes[2].mask_fn = mask;
    meshes[2].user = &edge;
    meshes[2].version = 1;
}

static rsm_desc sun_of_test(void)
{
    rsm_desc d = sun_desc(5, 2.2, SIDE);
    d.light.near_depth = -3;
    d.light.far_depth = 3;
    return d;
}

/* The map drawn fresh has the same texels, flux and statistics. */
static void is_fresh(const rsm_map *map, const rsm_stats *stats, const rsm_light *light, const rsm_mesh *meshes)
{
    rsm_desc d = sun_of_test();
    rsm_stats own;
    rsm_map *fresh;
    rsm_texel lights[50], expected[50];
    size_t count = 0, other = 0;
    d.light = *light;
    fresh = map_of(&d, meshes, 3, &own);
    assert_non_null(fresh);
    assert_memory_equal(rsm_map_texels(map), rsm_map_texels(fresh), SIDE * SIDE * sizeof(rsm_texel));
    assert_memory_equal(stats, &own, sizeof own);
    assert_int_equal(rsm_pixel_lights(&map, 1, 50, 3, lights, 50, &count), RSM_OK);
    assert_int_equal(rsm_pixel_lights((const rsm_map *const *)&fresh, 1, 50, 3, expected, 50, &other), RSM_OK);
    assert_int_equal(count, other);
    assert_memory_equal(lights, expected, count * sizeof *lights);
    rsm_map_free(fresh);
}

static rsm_map *map_of_test;
static rsm_light lamp;
static rsm_mesh scene[3];

static void next(int expected)
{
    rsm_stats stats;
    int kept = 7;
    assert_int_equal(rsm_redraw(map_of_test, &lamp, scene, 3, &kept, &stats), RSM_OK);
    assert_int_equal(kept, expected);
    is_fresh(map_of_test, &stats, &lamp, scene);
}

static void open_map(void)
{
    rsm_desc d = sun_of_test();
    lamp = d.light;
    make(scene);
    assert_int_equal(rsm_map_create(&d, &map_of_test), RSM_OK);
    next(0);
    next(1);
}

/* Each change alone is seen, and so is the way back. */
static void whatever_a_map_shows_is_drawn_anew_when_it_changes(void **state)
{
    float copy[12];
    (void)state;
    open_map();
#define CHANGED(field, value)                                                                                          \
    do {                                                                                                               \
        char was[sizeof(field)];                                                                                       \
        memcpy(was, &(field), sizeof was);                                                                             \
        (field) = value;                                                                                               \
        next(0);                                                                                                       \
        next(1);                                                                                                       \
        memcpy(&(field), was, sizeof was);                                                                             \
        next(0);                                                                                                       \
    } while (0)
    CHANGED(lamp.value[1], 6);
    CHANGED(lamp.direction[0], 0.3f);
    CHANGED(lamp.position[2], 0.1f);
    CHANGED(lamp.radius, 2.3f);
    CHANGED(lamp.far_depth, 2.5f);
    CHANGED(floor_at[10], 0.01f);
    CHANGED(cloth[8 * 3 + 2], 1.2f);
    CHANGED(turned[13], 0.2f);
    CHANGED(many[3 * (BALL - 3) + 2], 1.9f);            /* in the second piece */
    CHANGED(many[0], 1.9f);
    CHANGED(floor_indices[5], 1);
    CHANGED(cloth_indices[4], 1);
    CHANGED(scene[0].albedo[2], 0.35f);
    CHANGED(scene[1].material, 2);
    CHANGED(scene[0].tap_side, 2);
    edge = 0.7f;
    scene[2].version = 2;
    next(0);
    next(1);
    cloth[3] = 99;                                      /* between the vertices: nothing of the mesh */
    next(1);
    memcpy(copy, floor_at, sizeof copy);                /* elsewhere, but the same */
    scene[0].positions = copy;
    next(1);
    scene[1].transform = NULL;
    next(0);
    scene[2].vertex_count -= 3;
    next(0);
    scene[0].index_count = 3;
    next(0);
    scene[2].mask_fn = NULL;
    next(0);
    next(1);
    rsm_map_free(map_of_test);
}

static void functions_without_a_version_are_asked_each_time(void **state)
{
    (void)state;
    open_map();
    scene[2].version = 0;
    next(0);
    edge = 0.3f;
    next(0);
    scene[2].mask_fn = NULL;
    next(0);
    next(1);
    rsm_map_free(map_of_test);
}

static void what_else_is_in_a_map_is_not_kept(void **state)
{
    (void)state;
    open_map();
    assert_int_equal(rsm_map_restart(map_of_test, NULL), RSM_OK);
    assert_int_equal(rsm_finish(map_of_test, NULL), RSM_OK);        /* empty now */
    next(0);
    next(1);
    assert_int_equal(rsm_map_restart(map_of_test, NULL), RSM_OK);
    assert_int_equal(rsm_rasterize(map_of_test, scene, 1), RSM_OK);
    next(0);
    rsm_map_free(map_of_test);
}

static int left;

static int cancel(void *user, float fraction)
{
    (void)user, (void)fraction;
    return left-- <= 0;
}

/* After a failure nothing is kept that was not drawn whole. */
static void a_failed_drawing_is_drawn_again(void **state)
{
    rsm_desc d = sun_of_test();
    rsm_result result = RSM_ERR_CANCELLED;
    int kept;
    (void)state;
    make(scene);
    lamp = d.light;
    d.system.progress = cancel;
    left = 1 << 30;
    assert_int_equal(rsm_map_create(&d, &map_of_test), RSM_OK);
    next(0);
    for (int at = 0; result == RSM_ERR_CANCELLED; at++) {
        lamp.value[0] += 1;
        left = at;
        kept = 7;
        result = rsm_redraw(map_of_test, &lamp, scene, 3, &kept, NULL);
        if (result == RSM_ERR_CANCELLED) {
            rsm_light none = lamp;
            assert_int_equal(kept, 7);                  /* outputs are untouched */
            left = 1 << 30;
            lamp = none;
            next(0);
            next(1);
        }
    }
    assert_int_equal(result, RSM_OK);
    left = 1 << 30;
    next(1);
    assert_int_equal(rsm_redraw(NULL, &lamp, scene, 3, NULL, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_redraw(map_of_test, &lamp, NULL, 3, NULL, NULL), RSM_ERR_ARGUMENT);
    scene[0].vertex_stride = 13;
    assert_int_equal(rsm_redraw(map_of_test, &lamp, scene, 3, NULL, NULL), RSM_ERR_ARGUMENT);
    scene[0].vertex_stride = 0;
    lamp.radius = -1;
    assert_int_equal(rsm_redraw(map_of_test, &lamp, scene, 3, NULL, NULL), RSM_ERR_DESC);
    lamp.radius = d.light.radius;
    next(1);                                            /* errors of arguments leave the map */
    floor_indices[0] = 4;
    kept = 7;
    assert_int_equal(rsm_redraw(map_of_test, &lamp, scene, 3, &kept, NULL), RSM_ERR_INPUT);
    assert_int_equal(kept, 7);
    floor_indices[0] = 0;
    next(0);
    assert_int_equal(rsm_redraw(map_of_test, NULL, scene, 3, &kept, NULL), RSM_OK);
    assert_int_equal(kept, 1);
    rsm_map_free(map_of_test);
}

static void failing_memory_keeps_nothing_wrong(void **state)
{
    rsm_desc d = sun_of_test();
    rsm_result result;
    ledger l;
    (void)state;
    make(scene);
    lamp = d.light;
    d.system = ledger_system(&l);
    assert_int_equal(rsm_map_create(&d, &map_of_test), RSM_OK);
    do {
        size_t k = l.fail_at + 1;
        l.calls = 0;
        l.fail_at = k;
        result = rsm_redraw(map_of_test, &lamp, scene, 3, NULL, NULL);
        assert_true(result == RSM_OK || result == RSM_ERR_ALLOC);
        assert_int_equal(l.live, 1);
    } while (result != RSM_OK);
    assert_true(l.fail_at >= 4);
    l.fail_at = 0;
    next(1);
    rsm_map_free(map_of_test);
    assert_int_equal(l.live, 0);
}

static void backwards(void *user, size_t count, rsm_task task, void *context)
{
    (void)user;
    while (count--) task(context, count);
}

static void threads_change_no_key(void **state)
{
    rsm_desc d = sun_of_test();
    (void)state;
    make(scene);
    lamp = d.light;
    d.system.parallel_for = backwards;
    assert_int_equal(rsm_map_create(&d, &map_of_test), RSM_OK);
    next(0);
    next(1);
    many[3 * 33000] += 0.1f;
    next(0);
    rsm_map_free(map_of_test);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whatever_a_map_shows_is_drawn_anew_when_it_changes),
        cmocka_unit_test(functions_without_a_version_are_asked_each_time),
        cmocka_unit_test(what_else_is_in_a_map_is_not_kept),
        cmocka_unit_test(a_failed_drawing_is_drawn_again),
        cmocka_unit_test(failing_memory_keeps_nothing_wrong),
        cmocka_unit_test(threads_change_no_key),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
