/* envsh_errors_test - bad input by the table of platform.md C2: a specific error with outputs untouched, or finite
   results. */

#define ENVSHADOW_IMPLEMENTATION
#include "envshadow.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "unit/envsh_util.h"

#define NOT_A_NUMBER envsh__from_bits(0x7fc00000u)
#define INF envsh__from_bits(0x7f800000u)

static char untouched;
#define UNTOUCHED ((void *)&untouched)
static sky day;
static envsh_lights *good;
static const envsh_light *list;
static uint32_t count;
static envsh_maps *maps;
static const envsh_bounds box = { { -1, -1, -1 }, { 1, 1, 1 } };

static int setup(void **state)
{
    envsh_maps_desc d;
    (void)state;
    memset(&d, 0, sizeof d);
    d.map_size = 32;
    day = sky_alloc(ENVSH_MAP_LATLONG, 32, 16);
    sky_fill(&day, sunny);
    if (envsh_lights_build(NULL, &day.map, &good, NULL) != ENVSH_OK) return -1;
    list = envsh_lights_get(good, &count);
    return envsh_maps_create(&d, count, &maps) == ENVSH_OK ? 0 : -1;
}

static int teardown(void **state)
{
    (void)state;
    envsh_maps_free(maps);
    envsh_lights_free(good);
    sky_free(&day);
    return 0;
}

static void expect_build(envsh_result expected, const envsh_desc *d, const envsh_map *map)
{
    envsh_lights *l = (envsh_lights *)UNTOUCHED;
    envsh_stats stats, before;
    memset(&stats, 0x31, sizeof stats);
    before = stats;
    assert_int_equal(envsh_lights_build(d, map, &l, &stats), expected);
    if (expected == ENVSH_OK) {
        for (int c = 0; c < 3; c++) assert_true(stats.energy[c] >= 0 && stats.energy[c] < 1e32);
        envsh_lights_free(l);
        return;
    }
    assert_ptr_equal(l, UNTOUCHED);
    assert_memory_equal(&stats, &before, sizeof stats);
}

static void maps_are_checked(void **state)
{
    envsh_map m = day.map;
    envsh_desc d = desc_of(ENVSH_METHOD_DEFAULT, 0);
    (void)state;
    assert_int_equal(envsh_lights_build(NULL, &m, NULL, NULL), ENVSH_ERR_ARGUMENT);
    expect_build(ENVSH_ERR_ARGUMENT, NULL, NULL);
    expect_build(ENVSH_OK, NULL, &m);
    m.rgb = NULL;
    expect_build(ENVSH_ERR_MAP, NULL, &m);
    m = day.map;
    m.width = 0;
    expect_build(ENVSH_ERR_MAP, NULL, &m);
    m = day.map;
    m.projection = (envsh_projection)9;
    expect_build(ENVSH_ERR_MAP, NULL, &m);
    m.projection = ENVSH_MAP_CUBE;
    expect_build(ENVSH_ERR_MAP, NULL, &m);          /* 32 x 16 is no cube's face */
    m = day.map;
    m.texel_stride = 8;
    expect_build(ENVSH_ERR_MAP, NULL, &m);
    m.texel_stride = 14;
    expect_build(ENVSH_ERR_MAP, NULL, &m);
    m = day.map;
    m.width = m.height = 65536;
    expect_build(ENVSH_ERR_LIMIT, NULL, &m);
    m.width = UINT32_MAX;
    expect_build(ENVSH_ERR_LIMIT, NULL, &m);
    d.light_count = ENVSH_MAX_LIGHTS + 1;
    expect_build(ENVSH_ERR_DESC, &d, &day.map);
    d = desc_of((envsh_method)17, 5);
    expect_build(ENVSH_ERR_DESC, &d, &day.map);
    d = desc_of(ENVSH_METHOD_DEFAULT, 5);
    d.allocator.alloc_fn = ledger_alloc;
    expect_build(ENVSH_ERR_DESC, &d, &day.map);
}

/* Sizes and contents that are odd but allowed. */
static void odd_maps_work(void **state)
{
    static const uint32_t sizes[][2] = { { 1, 1 }, { 1, 9 }, { 9, 1 }, { 2, 2 }, { 3, 7 }, { 37, 5 } };
    (void)state;
    for (int m = 1; m < ENVSH_METHOD_COUNT; m++)
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++)
            for (int content = 0; content < 5; content++)
                for (uint32_t k = 1; k < 40; k += 13) {
                    int cube = sizes[i][0] == sizes[i][1];
                    sky s = sky_alloc(cube ? ENVSH_MAP_CUBE : ENVSH_MAP_LATLONG, sizes[i][0], sizes[i][1]);
                    envsh_desc d = desc_of((envsh_method)m, k);
                    envsh_lights *l;
                    const envsh_light *out;
                    uint32_t n;
                    d.split_sun = content & 1;
                    d.hemisphere = content == 2;
                    for (size_t t = 0; t < 3 * s.texels; t++)
                        s.rgb[t] = content == 0 ? 0 : content == 1 ? 1e30f : content == 2 ? 1 : content == 3 ? 1e-38f
                                                                                            : NOT_A_NUMBER;
                    assert_int_equal(envsh_lights_build(&d, &s.map, &l, NULL), ENVSH_OK);
                    out = envsh_lights_get(l, &n);
                    assert_in_range(n, content == 0 || content == 4 ? 0 : 1, content == 0 || content == 4 ? 0 : k);
                    for (uint32_t j = 0; j < n; j++) assert_true(envsh__light_finite(&out[j]));
                    assert_int_equal(envsh_lights_follow(l, &s.map, k + 1, NULL), ENVSH_OK);
                    envsh_lights_free(l);
                    sky_free(&s);
                }
}

static void lights_are_checked(void **state)
{
    envsh_light copy[128];
    envsh_map other = day.map;
    float m[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, sh[27], *rest;
    uint32_t n = 7;
    size_t texels = 7;
    char text[8];
    (void)state;
    memcpy(copy, list, count * sizeof *copy);
    assert_null(envsh_lights_get(NULL, &n));
    assert_int_equal(n, 0);
    assert_null(envsh_lights_strata(NULL, &texels));
    assert_int_equal(texels, 0);
    envsh_lights_free(NULL);
    assert_int_equal(envsh_lights_jitter(NULL, 0, 0, copy), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_lights_jitter(good, 0, 0, NULL), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_lights_follow(NULL, &day.map, 0, NULL), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_lights_follow(good, NULL, 0, NULL), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_lights_follow(good, &day.map, ENVSH_MAX_LIGHTS + 1, NULL), ENVSH_ERR_ARGUMENT);
    other.width = 16;
    assert_int_equal(envsh_lights_follow(good, &other, 0, NULL), ENVSH_ERR_ARGUMENT);
    other.rgb = NULL;
    assert_int_equal(envsh_lights_follow(good, &other, 0, NULL), ENVSH_ERR_MAP);
    assert_int_equal(envsh_match(NULL, 1, copy, count), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_match(list, count, NULL, 1), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_match(NULL, 0, copy, count), ENVSH_OK);
    assert_int_equal(envsh_rotate(copy, count, NULL), ENVSH_ERR_ARGUMENT);
    m[0] = 2;
    assert_int_equal(envsh_rotate(copy, count, m), ENVSH_ERR_ARGUMENT);
    m[0] = m[5] = m[10] = 2;                        /* even, but no rotation */
    assert_int_equal(envsh_rotate(copy, count, m), ENVSH_ERR_ARGUMENT);
    m[0] = NOT_A_NUMBER;
    assert_int_equal(envsh_rotate(copy, count, m), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_export_gltf(NULL, 0, NULL, 0), 0);
    assert_int_equal(envsh_export_gltf(list, 1, NULL, 9), 0);
    assert_true(envsh_export_gltf(list, 0, text, sizeof text) > 8);
    assert_int_equal(text[7], 0);
    rest = (float *)malloc(3 * day.texels * sizeof *rest);
    assert_non_null(rest);
    assert_int_equal(envsh_lights_residual(good, &day.map, NULL), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_lights_residual(NULL, &day.map, rest), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_lights_residual_sh(good, &day.map, NULL), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_lights_residual_sh(good, NULL, sh), ENVSH_ERR_ARGUMENT);
    free(rest);
    assert_string_equal(envsh_result_text((envsh_result)99), "unknown result");
    assert_string_equal(envsh_result_text(ENVSH_OK), "ok");
    assert_true(envsh_texel_solid_angle(ENVSH_MAP_LATLONG, 4, 4, 4, 0) <= 0);
}

static void expect_maps(envsh_result expected, uint32_t size, uint32_t guard, uint32_t side, uint32_t capacity)
{
    envsh_maps *m = (envsh_maps *)UNTOUCHED;
    envsh_maps_desc d;
    memset(&d, 0, sizeof d);
    d.map_size = size;
    d.guard = guard;
    d.max_side = side;
    assert_int_equal(envsh_maps_create(&d, capacity, &m), expected);
    if (expected == ENVSH_OK) envsh_maps_free(m);
    else assert_ptr_equal(m, UNTOUCHED);
}

static void atlas_is_checked(void **state)
{
    envsh_maps *m;
    envsh_maps_desc d;
    (void)state;
    expect_maps(ENVSH_ERR_DESC, 15, 0, 0, 1);
    expect_maps(ENVSH_ERR_DESC, 4097, 0, 0, 1);
    expect_maps(ENVSH_ERR_DESC, 64, 17, 0, 1);
    expect_maps(ENVSH_ERR_DESC, 64, 0, 63, 1);
    expect_maps(ENVSH_ERR_DESC, 64, 0, 40000, 1);
    expect_maps(ENVSH_ERR_ARGUMENT, 64, 0, 0, ENVSH_MAX_LIGHTS + 1);
    expect_maps(ENVSH_OK, 64, 16, 64, 3);           /* a page each */
    expect_maps(ENVSH_OK, 0, 0, 0, 0);
    assert_int_equal(envsh_maps_create(NULL, 1, NULL), ENVSH_ERR_ARGUMENT);
    memset(&d, 0, sizeof d);
    d.allocator.free_fn = ledger_free;
    assert_int_equal(envsh_maps_create(&d, 1, &m), ENVSH_ERR_DESC);
    memset(&d, 0, sizeof d);
    d.no_depth = 1;
    assert_int_equal(envsh_maps_create(&d, count, &m), ENVSH_OK);
    assert_int_equal(envsh_maps_begin(m, list, count, box), ENVSH_OK);
    assert_int_equal(envsh_maps_end(m), ENVSH_ERR_DESC);
    envsh_maps_free(m);
    envsh_maps_free(NULL);
}

static void drawing_is_checked(void **state)
{
    static const float p[] = { 0, 0, 0,  1, 0, 0,  0, 1, 0 };
    static const uint32_t inside[] = { 0, 1, 2 }, outside[] = { 0, 1, 3 };
    float m[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, depth[32 * 32] = { 0 };
    envsh_mesh mesh = { p, 3, 0, inside, 3 };
    envsh_light one = list[0];
    envsh_bounds b = box;
    envsh_maps *fresh;
    (void)state;
    assert_int_equal(envsh_maps_create(NULL, 1, &fresh), ENVSH_OK);
    assert_int_equal(envsh_maps_draw(fresh, &mesh, NULL), ENVSH_ERR_ORDER);
    assert_int_equal(envsh_maps_set(fresh, 0, depth, 0), ENVSH_ERR_ORDER);
    assert_int_equal(envsh_maps_end(fresh), ENVSH_ERR_ORDER);
    assert_int_equal(envsh_maps_begin(fresh, list, 2, box), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_maps_begin(fresh, NULL, 1, box), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_maps_begin(NULL, list, 1, box), ENVSH_ERR_ARGUMENT);
    envsh_maps_free(fresh);
    one.direction[0] = NOT_A_NUMBER;
    assert_int_equal(envsh_maps_begin(maps, &one, 1, box), ENVSH_ERR_ARGUMENT);
    one = list[0];
    one.direction[0] *= 2;
    assert_int_equal(envsh_maps_begin(maps, &one, 1, box), ENVSH_ERR_ARGUMENT);
    one = list[0];
    one.irradiance[2] = INF;
    assert_int_equal(envsh_maps_begin(maps, &one, 1, box), ENVSH_ERR_ARGUMENT);
    b.high[1] = NOT_A_NUMBER;
    assert_int_equal(envsh_maps_begin(maps, list, count, b), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_maps_begin(maps, list, count, envsh_bounds_of(NULL, 0, NULL)), ENVSH_OK);   /* empty */
    assert_int_equal(envsh_maps_begin(maps, list, count, box), ENVSH_OK);
    assert_int_equal(envsh_maps_draw(maps, NULL, NULL), ENVSH_ERR_ARGUMENT);
    m[3] = 1;
    assert_int_equal(envsh_maps_draw(maps, &mesh, m), ENVSH_ERR_ARGUMENT);
    mesh.indices = outside;
    assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_MESH);
    mesh.indices = inside;
    mesh.index_count = 2;
    assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_MESH);
    mesh.index_count = 3;
    mesh.vertex_stride = 10;
    assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_MESH);
    mesh.vertex_stride = 0;
    mesh.positions = NULL;
    assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_MESH);
    assert_int_equal(envsh_maps_set(maps, count, depth, 0), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_maps_set(maps, 0, NULL, 0), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_maps_set(maps, 0, depth, 64), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_maps_set(maps, 0, depth, 130), ENVSH_ERR_ARGUMENT);
}

/* Triangles of every bad kind, and bounds of every odd size: light stays finite. */
static void bad_geometry_is_harmless(void **state)
{
    static const float big[] = { 0, 1, 1e-30f, 1e10f, 1e38f, -1e38f };
    float p[9], e[3], n[3] = { 0, 1, 0 }, at[3] = { 0, 0, 0 };
    envsh_mesh mesh = { p, 3, 0, NULL, 0 };
    envsh_query q = envsh_query_default();
    uint64_t seed = 4;
    (void)state;
    q.points = at;
    q.normals = n;
    q.count = 1;
    for (int i = 0; i < 400; i++) {
        envsh_bounds b = box;
        for (int k = 0; k < 9; k++) {
            double r = rnd(&seed);
            p[k] = r < 0.1 ? NOT_A_NUMBER : r < 0.2 ? INF : r < 0.6 ? big[(int)(6 * rnd(&seed))]
                                                                    : (float)(2 * rnd(&seed) - 1);
        }
        if (i % 3 == 0) b = envsh_bounds_of(&mesh, 1, NULL);
        if (i % 3 == 1) b.low[i % 2] = b.high[i % 2];           /* flat */
        if (i % 7 == 1) b.low[0] = b.low[1] = b.low[2] = b.high[0] = b.high[1] = b.high[2] = 5;
        assert_int_equal(envsh_maps_begin(maps, list, count, b), ENVSH_OK);
        assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_OK);
        assert_int_equal(envsh_maps_end(maps), ENVSH_OK);
        q.filter = (envsh_filter)(i % ENVSH_FILTER_COUNT);
        q.radius = 2;
        at[0] = i % 11 == 0 ? 1e30f : 0;
        assert_int_equal(envsh_shade(maps, &q, e), ENVSH_OK);
        for (int c = 0; c < 3; c++) assert_true(envsh__finite(e[c]) && e[c] >= 0);
    }
    at[1] = NOT_A_NUMBER;
    assert_int_equal(envsh_shade(maps, &q, e), ENVSH_OK);
    assert_true(e[0] <= 0);
    at[1] = 0;
    n[1] = INF;
    assert_int_equal(envsh_shade(maps, &q, e), ENVSH_OK);
    assert_true(envsh__finite(e[0]));
}

/* Under a roof that covers the whole tile it is dark, however far down: the kernel's half axes stay numbers. */
static void far_below_a_roof_it_is_dark(void **state)
{
    static const float roof[] = { -9, 0.5f, -9, 9, 0.5f, -9, 0, 0.5f, 9 };
    static const float depths[] = { 0.25f, 10, 1e6f, 1e15f, 1e30f, 1e37f, 3e38f };
    envsh_light sun = { { 0, 1, 0 }, { 1, 1, 1 }, 0.1f, { 0.3f, 0, 0 }, { 0, 0, 0.2f }, 0, 0 };
    envsh_mesh mesh = { roof, 3, 0, NULL, 0 };
    envsh_query q = envsh_query_default();
    (void)state;
    assert_int_equal(envsh_maps_begin(maps, &sun, 1, box), ENVSH_OK);
    assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_OK);
    assert_int_equal(envsh_maps_end(maps), ENVSH_OK);
    for (size_t i = 0; i < sizeof depths / sizeof depths[0]; i++)
        for (int filter = 0; filter < ENVSH_FILTER_COUNT; filter++) {
            float p[3] = { 0, -depths[i], 0 }, n[3] = { 0, 1, 0 }, out[3] = { 7, 7, 7 };
            q.points = p;
            q.normals = n;
            q.count = 1;
            q.radius = 2;
            q.filter = (envsh_filter)filter;
            assert_int_equal(envsh_shade(maps, &q, out), ENVSH_OK);
            assert_true(out[0] >= 0 && out[0] <= 0);
        }
    sun.axis_u[0] = 1e30f;
    assert_int_equal(envsh_maps_begin(maps, &sun, 1, box), ENVSH_ERR_ARGUMENT);
}

static void queries_are_checked(void **state)
{
    float p[3] = { 0, 0, 0 }, n[3] = { 0, 1, 0 }, out[3] = { 7, 7, 7 };
    envsh_query good_query = envsh_query_default(), q;
    uint32_t sizes[2] = { 1, 0 };
    double ms[2] = { 1, 1 };
    envsh_cost cost;
    (void)state;
    good_query.points = p;
    good_query.normals = n;
    good_query.count = 1;
    assert_int_equal(envsh_maps_begin(maps, list, count, box), ENVSH_OK);
    assert_int_equal(envsh_shade(maps, &good_query, out), ENVSH_ERR_ORDER);     /* no end yet */
    assert_int_equal(envsh_maps_end(maps), ENVSH_OK);
#define REFUSED(change) \
    do { q = good_query; change; assert_int_equal(envsh_shade(maps, &q, out), ENVSH_ERR_ARGUMENT); } while (0)
    REFUSED(q.points = NULL);
    REFUSED(q.normals = NULL);
    REFUSED(q.point_stride = 8);
    REFUSED(q.normal_stride = 13);
    REFUSED(q.geometric_stride = 4);
    REFUSED(q.filter = (envsh_filter)9);
    REFUSED(q.taps = 0);
    REFUSED(q.taps = ENVSH_MAX_TAPS + 1);
    REFUSED(q.radius = 65);
    REFUSED(q.radius = NOT_A_NUMBER);
    REFUSED(q.bias = -1);
    REFUSED(q.bias = INF);
    REFUSED(q.extent_scale = -1);
    REFUSED(q.filter = ENVSH_FILTER_SMOOTH; q.radius = 0.25f);
    REFUSED(q.filter = ENVSH_FILTER_PCF; q.radius = 33);
    assert_int_equal(envsh_shade(NULL, &good_query, out), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_shade(maps, NULL, out), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_shade(maps, &good_query, NULL), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_visible(maps, count, &good_query, out), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_visible(maps, ENVSH_NO_LIGHT, &good_query, out), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_illuminate(maps, list, count, box, NULL, NULL, &good_query, out), ENVSH_ERR_ARGUMENT);
    assert_true(out[0] >= 7 && out[0] <= 7);
    q = good_query;
    q.count = 0;
    assert_int_equal(envsh_shade(maps, &q, NULL), ENVSH_OK);
    assert_int_equal(envsh_cost_fit(8, sizes, ms, 2, &cost), 0);                /* a cluster of 0 */
    assert_int_equal(envsh_cost_fit(8, NULL, ms, 2, &cost), 0);
    sizes[1] = 4;
    ms[0] = (double)NOT_A_NUMBER;
    assert_int_equal(envsh_cost_fit(8, sizes, ms, 2, &cost), 0);
    assert_int_equal(envsh_cluster_size(NULL, 8, 8), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(maps_are_checked),
        cmocka_unit_test(odd_maps_work),
        cmocka_unit_test(lights_are_checked),
        cmocka_unit_test(atlas_is_checked),
        cmocka_unit_test(drawing_is_checked),
        cmocka_unit_test(bad_geometry_is_harmless),
        cmocka_unit_test(far_below_a_roof_it_is_dark),
        cmocka_unit_test(queries_are_checked),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
