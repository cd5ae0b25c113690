/* alloc_test - an allocation that fails, at every site: once, and from then on. No crash, no leak, RSM_ERR_ALLOC,
   outputs untouched; and the peaks that the header's top comment promises. */

#include "rsm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include "util.h"

enum { SIDE = 12 };

static model disc;
static rsm_mesh mesh;
static rsm_map *good;
static float positions[3 * SIDE * SIDE], normals[3 * SIDE * SIDE], result[3 * SIDE * SIDE], before[3 * SIDE * SIDE];
static rsm_points points;

static int setup(void **state)
{
    rsm_desc d = sun_desc(1, 1.2, 32);
    int i;
    (void)state;
    disc = model_disc(32, 1);
    mesh = mesh_of(&disc, 0.5);
    good = map_of(&d, &mesh, 1, NULL);
    for (i = 0; i < SIDE * SIDE; i++) {
        set3(positions + 3 * i, i % SIDE * 0.1, 1, i / SIDE * 0.1);
        set3(normals + 3 * i, 0, -1, 0);
    }
    points = points_of(positions, normals, SIDE * SIDE, SIDE);
    return good ? 0 : -1;
}

static int teardown(void **state)
{
    (void)state;
    rsm_map_free(good);
    model_free(&disc);
    return 0;
}

typedef rsm_result (*action)(const rsm_system *system);

static rsm_result act_map(const rsm_system *system)
{
    rsm_desc d = sun_desc(1, 1.2, 16);
    rsm_map *map = NULL;
    rsm_result r;
    d.system = *system;
    r = rsm_map_create(&d, &map);
    if (r != RSM_OK) {
        assert_null(map);
        return r;
    }
    r = rsm_rasterize(map, &mesh, 1);
    if (r == RSM_OK) r = rsm_finish(map, NULL);
    rsm_map_free(map);
    return r;
}

static rsm_result untouched(rsm_result r)
{
    if (r != RSM_OK) assert_memory_equal(result, before, sizeof result);
    return r;
}

static rsm_result act_flux(const rsm_system *system)
{
    static const rsm_material shiny = { { 0.5f, 0.5f, 0.5f }, 10 };
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 40);
    g.system = *system;
    g.materials = &shiny;
    g.material_count = 1;
    return untouched(rsm_gather((const rsm_map *const *)&good, 1, &g, &points, result, NULL));
}

static rsm_result act_pattern(const rsm_system *system)
{
    rsm_gather_desc g = gather_desc(RSM_PATTERN_MIXED, 40);
    g.system = *system;
    return untouched(rsm_gather((const rsm_map *const *)&good, 1, &g, &points, result, NULL));
}

static rsm_result act_near(const rsm_system *system)
{
    static const rsm_material shiny = { { 0.5f, 0.5f, 0.5f }, 10 };
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    g.system = *system;
    g.materials = &shiny;
    g.material_count = 1;
    g.near_field = 3;
    return untouched(rsm_gather((const rsm_map *const *)&good, 1, &g, &points, result, NULL));
}

static rsm_result act_list(const rsm_system *system)
{
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    g.system = *system;
    return untouched(rsm_gather_list(rsm_map_texels(good), 1024, &g, &points, result, NULL));
}

static rsm_result act_interpolate(const rsm_system *system)
{
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 40);
    g.system = *system;
    return untouched(rsm_interpolate((const rsm_map *const *)&good, 1, &g, NULL, &points, result, NULL));
}

static rsm_result act_cluster(const rsm_system *system)
{
    rsm_texel clusters[8];
    size_t count = 77;
    rsm_result r = rsm_cluster(rsm_map_texels(good), 1024, 8, system, clusters, &count);
    if (r != RSM_OK) assert_int_equal(count, 77);
    return r;
}

static rsm_result act_noise(const rsm_system *system)
{
    float values[64];
    return rsm_blue_noise(8, 1, system, values);
}

static void fail_everywhere(action act, const char *name)
{
    size_t at, calls, on;
    ledger l;
    rsm_system system = ledger_system(&l);
    if (act(&system) != RSM_OK) fail_msg("%s fails with all its memory", name);
    calls = l.calls;
    if (l.live || !calls) fail_msg("%s: %lu allocations, %lu left", name, (unsigned long)calls, (unsigned long)l.live);
    for (on = 0; on < 2; on++)
        for (at = 1; at <= calls; at++) {
            rsm_result r;
            memset(result, 0x5a, sizeof result);
            memcpy(before, result, sizeof result);
            system = ledger_system(&l);
            l.fail_at = at;
            l.fail_on = (int)on;
            r = act(&system);
            if (r != RSM_ERR_ALLOC || l.live)
                fail_msg("%s, allocation %lu: result %d, %lu left", name, (unsigned long)at, (int)r,
                         (unsigned long)l.live);
        }
}

static void every_call_survives_failing_memory(void **state)
{
    (void)state;
    fail_everywhere(act_map, "map");
    fail_everywhere(act_flux, "gather");
    fail_everywhere(act_near, "gather, near texels as surfaces");
    fail_everywhere(act_pattern, "gather, pattern");
    fail_everywhere(act_list, "list");
    fail_everywhere(act_interpolate, "interpolate");
    fail_everywhere(act_cluster, "cluster");
    fail_everywhere(act_noise, "blue noise");
}

/* rsm.h: "A map takes 56 bytes a texel ..., interpolation 11 bytes a pixel"; of rsm_cluster: "4 bytes a light, 128 a
   cluster". */
static void memory_is_what_the_manual_says(void **state)
{
    ledger l;
    rsm_system system = ledger_system(&l);
    rsm_desc d = sun_desc(1, 1.2, 64);
    rsm_map *map;
    size_t texels = 64 * 64, bound = 56 * texels + 8 * 65 + 1024;
    (void)state;
    assert_in_range(rsm_map_bytes(&d), 56 * texels, bound);
    d.system = system;
    assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
    assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_OK);
    assert_true(l.peak <= bound + 8 * (disc.indices / 3 + 1) + 4 * texels);
    assert_int_equal(rsm_finish(map, NULL), RSM_OK);
    rsm_map_free(map);
    assert_int_equal(l.live, 0);
    {
        rsm_interpolation in;
        rsm_texel clusters[100];
        rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 4);
        float *places = (float *)calloc(3 * 256 * 256, sizeof *places), *up, *out;
        rsm_points p;
        size_t i, count;
        assert_non_null(places);
        up = (float *)calloc(3 * 256 * 256, sizeof *up);
        out = (float *)calloc(3 * 256 * 256, sizeof *out);
        assert_true(up && out);
        memset(&in, 0, sizeof in);
        for (i = 0; i < 256 * 256; i++) {
            set3(places + 3 * i, (double)(i % 256) * 0.01 - 1.28, 1, (double)(i / 256) * 0.01 - 1.28);
            set3(up + 3 * i, 0, -1, 0);
        }
        p = points_of(places, up, 256 * 256, 256);
        g.system = ledger_system(&l);
        assert_int_equal(rsm_interpolate((const rsm_map *const *)&good, 1, &g, &in, &p, out, NULL), RSM_OK);
        assert_in_range(l.peak, 9 * 256 * 256, 11 * 256 * 256 + 4096);
        free(places);
        free(up);
        free(out);
        system = ledger_system(&l);
        assert_int_equal(rsm_cluster(rsm_map_texels(good), 1024, 100, &system, clusters, &count), RSM_OK);
        assert_in_range(l.peak, 4 * 1024 + 128 * 100, 4 * 1024 + 128 * 100 + 64);
    }
}

/* Memory of the caller's: too small, misaligned, exact. */
static void the_callers_memory_must_be_large_and_aligned(void **state)
{
    rsm_desc d = sun_desc(1, 1.2, 16);
    size_t size = rsm_map_bytes(&d);
    char *memory = (char *)malloc(size + 16), *aligned;
    rsm_map *map = NULL;
    (void)state;
    assert_non_null(memory);
    aligned = memory + (16 - (uintptr_t)memory % 16) % 16;
    assert_int_equal(rsm_map_init(&d, aligned, size - 1, &map), RSM_ERR_MEMORY);
    assert_int_equal(rsm_map_init(&d, aligned + 1, size, &map), RSM_ERR_MEMORY);
    assert_null(map);
    assert_int_equal(rsm_map_init(&d, aligned, size, &map), RSM_OK);
    assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_OK);
    assert_int_equal(rsm_finish(map, NULL), RSM_OK);
    rsm_map_free(map);                           /* leaves it alone */
    assert_int_equal(rsm_map_init(&d, aligned, size, &map), RSM_OK);
    free(memory);
}

/* A map of its own that is begun anew is one made anew, in the same memory. */
static void maps_begin_anew(void **state)
{
    rsm_desc d = sun_desc(1, 1.2, 16), lamp = d;
    rsm_light other, spot;
    rsm_map *map, *fresh;
    size_t calls, texels;
    int way;
    ledger l;
    (void)state;
    d.system = ledger_system(&l);
    d.light.kind = RSM_LIGHT_PATCH;
    set3(d.light.position, 0, 1, 0);
    set3(d.light.direction, 0, -1, 0);
    assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
    calls = l.calls;
    other = d.light;
    other.position[1] = 0.5f;
    spot = other;
    spot.kind = RSM_LIGHT_SPOT;
    spot.cone_half_angle = 0.5f;
    for (way = 0; way < 4; way++) {
        const rsm_light *light = way == 0 ? NULL : way == 1 ? &other : way == 2 ? &spot : &d.light;
        assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_OK);
        assert_int_equal(rsm_finish(map, NULL), RSM_OK);
        assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_ERR_ORDER);
        assert_int_equal(rsm_map_restart(map, light), RSM_OK);
        assert_true(rsm_map_texels(map)[0].depth >= RSM_FAR);
        assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_OK);
        assert_int_equal(rsm_finish(map, NULL), RSM_OK);
        lamp.light = light ? *light : d.light;
        assert_int_equal(rsm_map_create(&lamp, &fresh), RSM_OK);
        assert_int_equal(rsm_rasterize(fresh, &mesh, 1), RSM_OK);
        assert_int_equal(rsm_finish(fresh, NULL), RSM_OK);
        assert_int_equal(map_faces(map), way == 2 ? 1 : 5);
        assert_int_equal(map_faces(fresh), map_faces(map));
        texels = (size_t)map_faces(map) * 16 * 16;
        assert_memory_equal(rsm_map_texels(map), rsm_map_texels(fresh), texels * sizeof(rsm_texel));
        rsm_map_free(fresh);
        assert_int_equal(rsm_map_restart(map, NULL), RSM_OK);
    }
    assert_true(l.live == 1 && l.calls > calls);            /* the rasteriser's scratch */
    other.kind = RSM_LIGHT_POINT;
    assert_int_equal(rsm_map_restart(map, &other), RSM_ERR_LIMIT);
    other.value[0] = -1;
    assert_int_equal(rsm_map_restart(map, &other), RSM_ERR_DESC);
    assert_int_equal(rsm_map_restart(NULL, &other), RSM_ERR_ARGUMENT);
    assert_int_equal(map_faces(map), 5);
    rsm_map_free(map);
    assert_int_equal(l.live, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_call_survives_failing_memory), cmocka_unit_test(memory_is_what_the_manual_says),
        cmocka_unit_test(the_callers_memory_must_be_large_and_aligned), cmocka_unit_test(maps_begin_anew)
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
