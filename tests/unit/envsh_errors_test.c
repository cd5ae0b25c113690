/* envsh_errors_test - bad input: a specific error with outputs untouched, or finite
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
    m.texel_stride = SIZE_MAX & ~(size_t)3;
    expect_build(ENVSH_ERR_LIMIT, NULL, &m);
    m = day.map;
    m.height = 0;
    expect_build(ENVSH_ERR_MAP, NULL, &m);
    m.height = (1u << 27) + 1;
    m.width = 1;
    expect_build(ENVSH_ERR_LIMIT, NULL, &m);
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
    /* No rotation: projective, not finite, flat, of several scales, sheared, mirrored. */
    const struct { int at; float value; } wrong[] = {
        { 3, 1 }, { 7, 1 }, { 11, 1 }, { 15, 2 }, { 0, NOT_A_NUMBER }, { 14, INF }, { 0, 1e30f }, { 0, 0 }, { 5, 0 },
        { 10, 0 }, { 0, 2 }, { 5, 2 }, { 10, 2 }, { 4, 0.01f }, { 8, 0.01f }, { 9, 0.01f }, { 0, -1 }
    };
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
    assert_int_equal(envsh_lights_residual_sh(good, &other, sh), ENVSH_ERR_ARGUMENT);
    other = day.map;
    other.height = 8;
    assert_int_equal(envsh_lights_follow(good, &other, 0, NULL), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_lights_residual_sh(good, &other, sh), ENVSH_ERR_ARGUMENT);
    other = day.map;
    other.projection = ENVSH_MAP_CUBE;
    other.height = 32;                              /* as wide, but six faces */
    assert_int_equal(envsh_lights_follow(good, &other, 0, NULL), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_lights_residual_sh(good, &other, sh), ENVSH_ERR_ARGUMENT);
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
    assert_int_equal(envsh_rotate(NULL, 1, m), ENVSH_ERR_ARGUMENT);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        memset(m, 0, sizeof m);
        m[0] = m[5] = m[10] = m[15] = 1;
        assert_int_equal(envsh_rotate(copy, count, m), ENVSH_OK);
        m[wrong[i].at] = wrong[i].value;
        assert_int_equal(envsh_rotate(copy, count, m), ENVSH_ERR_ARGUMENT);
    }
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
    other = day.map;
    other.rgb = NULL;
    assert_int_equal(envsh_lights_residual_sh(good, &other, sh), ENVSH_ERR_MAP);
    assert_int_equal(envsh_match(NULL, 0, NULL, 0), ENVSH_OK);
    assert_int_equal(envsh_rotate(NULL, 0, (const float[16]){ 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }),
                     ENVSH_OK);
    assert_null(envsh_lights_get(NULL, NULL));
    assert_ptr_equal(envsh_lights_get(good, NULL), list);
    assert_null(envsh_lights_strata(NULL, NULL));
    assert_non_null(envsh_lights_strata(good, NULL));
    free(rest);
    assert_string_equal(envsh_result_text((envsh_result)99), "unknown result");
    assert_string_equal(envsh_result_text(ENVSH_OK), "ok");
    assert_true(envsh_texel_solid_angle(ENVSH_MAP_LATLONG, 4, 4, 4, 0) <= 0);
    assert_true(envsh_texel_solid_angle(ENVSH_MAP_LATLONG, 4, 4, 0, 4) <= 0);
}

/* A light that shines down -Z has no shortest turn from +Z; colours of black are white times nothing; large numbers. */
static double dot3(const float *a, const float *b)
{
    return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

static void odd_lights_are_exported(void **state)
{
    envsh_light l[2];
    char text[1000];
    (void)state;
    memset(l, 0, sizeof l);
    l[0].direction[2] = -1;
    l[0].irradiance[0] = l[0].irradiance[1] = 2.5e20f;
    l[0].irradiance[2] = 5e20f;
    l[1].direction[2] = 1;
    assert_true(envsh_export_gltf(l, 2, text, sizeof text) < sizeof text);
    assert_non_null(strstr(text, "\"color\":[5.00000000e-1,5.00000000e-1,1.00000000e0],"
                                 "\"intensity\":5.00000010e20}"));          /* what 5e20f is */
    assert_non_null(strstr(text, "\"color\":[1.00000000e0,1.00000000e0,1.00000000e0],\"intensity\":0}"));
    assert_non_null(strstr(text, "{\"rotation\":[1.00000000e0,0,0,0]"));
    assert_non_null(strstr(text, "0,0,1.00000000e0]"));
    l[0].irradiance[1] = INF;                       /* JSON has no word for these, and no end of their digits came */
    l[0].irradiance[2] = NOT_A_NUMBER;
    l[1].irradiance[0] = -INF;
    l[1].direction[0] = INF;
    assert_true(envsh_export_gltf(l, 2, text, sizeof text) < sizeof text);
    assert_non_null(strstr(text, "\"color\":[0,0,0],\"intensity\":0}"));
    assert_null(strstr(text, "-0"));
}

/* Points far from the map, or at none, have directions all the same. */
static void any_point_has_a_direction(void **state)
{
    const float odd[] = { 1e20f, -1e20f, 3e9f, INF, -INF, NOT_A_NUMBER, 1e4f, 0 };
    float d[3], turned[3];
    (void)state;
    for (int cube = 0; cube < 2; cube++)
        for (size_t i = 0; i < 64; i++) {
            envsh_projection p = cube ? ENVSH_MAP_CUBE : ENVSH_MAP_LATLONG;
            envsh_texel_direction(p, 8, 8, 4, odd[i / 8], odd[i % 8], d);
            CLOSE(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], 1, 1e-6);
        }
    for (int turn = -2; turn <= 2; turn++) {            /* whole turns of the azimuth are none */
        envsh_texel_direction(ENVSH_MAP_LATLONG, 16, 8, 0, 3.25f, 2.5f, d);
        envsh_texel_direction(ENVSH_MAP_LATLONG, 16, 8, 0, 3.25f + 16 * (float)turn, 2.5f, turned);
        for (int c = 0; c < 3; c++) CLOSE(d[c], turned[c], 1e-6);
    }
}

/* A rotation that is a thousandth too long is allowed; done every frame, it must not blow lights up. */
static void turning_often_keeps_extents(void **state)
{
    const float s = 1.0009f, m[16] = { 0, 0, -s, 0, 0, s, 0, 0, s, 0, 0, 0, 0, 0, 0, 1 };
    envsh_light l = list[0];
    (void)state;
    for (int i = 0; i < 4000; i++) assert_int_equal(envsh_rotate(&l, 1, m), ENVSH_OK);
    for (int c = 0; c < 3; c++) {
        CLOSE(l.direction[c], list[0].direction[c], 1e-4);
        CLOSE(l.axis_u[c], list[0].axis_u[c], 1e-3 * sqrt(dot3(list[0].axis_u, list[0].axis_u)));
        CLOSE(l.axis_v[c], list[0].axis_v[c], 1e-3 * sqrt(dot3(list[0].axis_u, list[0].axis_u)));
    }
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
    {
        envsh_query q = envsh_query_default();
        envsh_mesh nothing = { NULL, 0, 0, NULL, 0 };
        envsh_atlas before, atlas;
        uint32_t n = 7;
        float depth[32 * 32] = { 0 };
        assert_int_equal(envsh_maps_draw(m, &nothing, NULL), ENVSH_ERR_DESC);   /* there are no maps to draw into */
        assert_int_equal(envsh_maps_set(m, 0, depth, 0), ENVSH_ERR_DESC);
        assert_int_equal(envsh_shade(m, &q, NULL), ENVSH_ERR_DESC);
        memset(&atlas, 0x31, sizeof atlas);
        before = atlas;
        envsh_maps_atlas(NULL, &atlas);
        envsh_maps_atlas(m, NULL);
        assert_memory_equal(&atlas, &before, sizeof atlas);
        assert_null(envsh_maps_views(NULL, &n));
        assert_int_equal(n, 0);
        assert_ptr_equal(envsh_maps_views(m, NULL), envsh_maps_views(m, &n));
        assert_int_equal(n, count);
    }
    envsh_maps_free(m);
    envsh_maps_free(NULL);
    assert_int_equal(envsh_maps_end(NULL), ENVSH_ERR_ARGUMENT);
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
    assert_int_equal(envsh_maps_draw(NULL, &mesh, NULL), ENVSH_ERR_ARGUMENT);
    for (int i = 3; i < 16; i += 4) {
        m[i] += 1;
        assert_int_equal(envsh_maps_draw(maps, &mesh, m), ENVSH_ERR_ARGUMENT);
        m[i] -= 1;
    }
    m[12] = INF;
    assert_int_equal(envsh_maps_draw(maps, &mesh, m), ENVSH_ERR_ARGUMENT);
    mesh.indices = outside;
    assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_MESH);
    mesh.indices = inside;
    mesh.index_count = 2;
    assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_MESH);
    mesh.index_count = 3;
    mesh.vertex_stride = 10;
    assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_MESH);
    mesh.vertex_stride = 14;
    assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_MESH);
    mesh.vertex_stride = SIZE_MAX & ~(size_t)3;
    assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_MESH);
    mesh.vertex_stride = 0;
    mesh.positions = NULL;
    assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_MESH);
    assert_int_equal(envsh_maps_set(NULL, 0, depth, 0), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_maps_set(maps, count, depth, 0), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_maps_set(maps, 0, NULL, 0), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_maps_set(maps, 0, depth, 64), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_maps_set(maps, 0, depth, 130), ENVSH_ERR_ARGUMENT);
}

/* A mesh drawn with a transform, by strides, casts the shadow of one that was moved before; so do its bounds. */
static void transforms_move_meshes(void **state)
{
    static const float p[3][4] = { { -0.5f, 0, -0.5f, 9 }, { 0.5f, 0, -0.5f, 9 }, { 0, 0, 0.75f, 9 } };
    static const float turn[16] = { 0, 0, 0.5f, 0, 0, 0.5f, 0, 0, -0.5f, 0, 0, 0, 0.25f, 0.5f, -0.125f, 1 };
    float moved[3][3];
    envsh_mesh mesh = { p[0], 3, 16, NULL, 0 }, still = { moved[0], 3, 0, NULL, 0 };
    envsh_bounds a, b;
    envsh_atlas atlas;
    float *depth;
    (void)state;
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 3; c++)
            moved[i][c] = turn[c] * p[i][0] + turn[4 + c] * p[i][1] + turn[8 + c] * p[i][2] + turn[12 + c];
    a = envsh_bounds_of(&mesh, 1, turn);
    b = envsh_bounds_of(&still, 1, NULL);
    assert_memory_equal(&a, &b, sizeof a);
    assert_true(a.low[1] >= 0.5f && a.high[1] <= 0.5f && a.high[0] > 0.49f);
    mesh.positions = NULL;                          /* nothing there: as if there were no mesh */
    a = envsh_bounds_of(&mesh, 1, turn);
    assert_true(a.low[0] > a.high[0]);
    mesh.positions = p[0];
    assert_int_equal(envsh_maps_begin(maps, list, count, box), ENVSH_OK);
    assert_int_equal(envsh_maps_draw(maps, &still, NULL), ENVSH_OK);
    envsh_maps_atlas(maps, &atlas);
    const size_t texels = (size_t)atlas.width * atlas.height * atlas.pages;
    depth = (float *)malloc(texels * sizeof *depth);
    assert_non_null(depth);
    memcpy(depth, atlas.depth, texels * sizeof *depth);
    assert_int_equal(envsh_maps_begin(maps, list, count, box), ENVSH_OK);
    assert_int_equal(envsh_maps_draw(maps, &mesh, turn), ENVSH_OK);
    size_t hit = 0, other = 0;
    for (size_t i = 0; i < texels; i++) {
        hit += depth[i] < 1;
        other += (depth[i] < 1) != (atlas.depth[i] < 1) || fabsf(depth[i] - atlas.depth[i]) > 1e-4f;
    }
    printf("texels %.0f, hit %.0f, other %.0f\n", (double)texels, (double)hit, (double)other);
    assert_true(hit > 400 && other <= hit / 100);              /* a texel on an edge, by rounding */
    free(depth);
}

/* Where texels are wider one way than the other, points move by the wider: with 2 a point under an occluder that is 0.4
   above comes out over it (a quarter of a texel where the light is overhead), with 1 it stays below. */
static void points_move_by_the_wider_side(void **state)
{
    static const float sides[3][2] = { { 2, 1 }, { 1, 2 }, { 1, 1 } };
    const float point[3] = { 0, 0, 0 }, up[3] = { 0, 0, 1 };
    float depth[16];
    envsh_query q = envsh_query_default();
    (void)state;
    q.filter = ENVSH_FILTER_PLAIN;
    for (int i = 0; i < 16; i++) depth[i] = 0.5f - 0.4f / 100;
    for (int i = 0; i < 3; i++) {
        envsh_view v;
        memset(&v, 0, sizeof v);
        v.lookup[3] = v.lookup[7] = 2;
        v.lookup[10] = -1.0f / 100;
        v.lookup[11] = 0.5f;
        v.right[0] = v.up[1] = v.direction[2] = 1;
        v.depth_range = 100;
        memcpy(v.texel, sides[i], sizeof v.texel);
        assert_true(envsh_visibility_twin(&v, depth, 4, 1, 4, &q, point, up, 0) == (i < 2 ? 1.0f : 0.0f));
    }
}

static envsh_result draw_fails(void *user, envsh_maps *m)
{
    (void)m;
    return *(envsh_result *)user;
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

/* ---- progress ---- */

typedef struct watch { int calls, stop_at; float last; } watch;

static int look(void *user, float fraction)
{
    watch *w = user;
    assert_true(fraction >= w->last && fraction <= 1);
    w->last = fraction;
    return w->calls++ == w->stop_at;
}

static envsh_result draw_twice(void *user, envsh_maps *m)
{
    envsh_result result = envsh_maps_draw(m, user, NULL);
    return result == ENVSH_OK ? envsh_maps_draw(m, user, NULL) : result;
}

/* One fraction from 0 to 1 over all clusters; each of its calls may cancel; what follows is as if nothing had been. */
static void every_call_of_progress_may_cancel(void **state)
{
    static const float corners[] = { -0.5f, 0.2f, -0.5f, 0.5f, 0.2f, -0.5f, 0, 0.2f, 0.5f };
    envsh_mesh mesh = { corners, 3, 0, NULL, 0 };
    envsh_query q = envsh_query_default();
    envsh_maps_desc d;
    envsh_maps *m;
    watch w = { 0, -1, 0 };
    enum { POINTS = 700, LIGHTS = 14 };         /* five clusters of three, the last of two */
    float points[3 * POINTS], normals[3 * POINTS], plain[3 * POINTS], out[3 * POINTS];
    int all;
    (void)state;
    for (int i = 0; i < POINTS; i++) {
        points[3 * i] = (float)(i % 26) / 13 - 1;
        points[3 * i + 1] = normals[3 * i] = normals[3 * i + 2] = 0;
        points[3 * i + 2] = (float)(i / 26) / 13 - 1;
        normals[3 * i + 1] = 1;
    }
    q.points = points;
    q.normals = normals;
    q.count = POINTS;
    memset(&d, 0, sizeof d);
    d.map_size = 32;
    assert_int_equal(envsh_maps_create(&d, 3, &m), ENVSH_OK);
    assert_int_equal(envsh_illuminate(m, list, LIGHTS, box, draw_twice, &mesh, &q, plain), ENVSH_OK);
    envsh_maps_free(m);
    d.progress = look;
    d.progress_user = &w;
    assert_int_equal(envsh_maps_create(&d, 3, &m), ENVSH_OK);
    assert_int_equal(envsh_illuminate(m, list, LIGHTS, box, draw_twice, &mesh, &q, out), ENVSH_OK);
    assert_memory_equal(out, plain, sizeof out);
    assert_true(w.last >= 1 && w.last <= 1);
    all = w.calls;
    assert_true(count >= LIGHTS && all > 3 * ((LIGHTS + 2) / 3));
    for (int i = 0; i < all; i++) {
        w.calls = 0;
        w.stop_at = i;
        w.last = 0;
        assert_int_equal(envsh_illuminate(m, list, LIGHTS, box, draw_twice, &mesh, &q, out), ENVSH_ERR_CANCELLED);
        assert_int_equal(w.calls, i + 1);
    }
    w.stop_at = -1;
    w.last = 0;
    assert_int_equal(envsh_illuminate(m, list, LIGHTS, box, draw_twice, &mesh, &q, out), ENVSH_OK);
    assert_memory_equal(out, plain, sizeof out);
    for (int i = 0; i < 2; i++) {           /* by themselves they go from 0 to 1 */
        w.last = 0;
        assert_int_equal(i ? envsh_shade(m, &q, out) : envsh_visible(m, 0, &q, out), ENVSH_OK);
        assert_true(w.last >= 1 && w.last <= 1);
    }
    w.last = 0;
    assert_int_equal(envsh_maps_draw(m, &mesh, NULL), ENVSH_OK);
    assert_true(w.last >= 1 && w.last <= 1);
    envsh_maps_free(m);
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
    {
        envsh_result says = ENVSH_ERR_MESH;
        envsh_maps *none;
        const envsh_query *g = &good_query;
        assert_int_equal(envsh_illuminate(NULL, list, count, box, draw_fails, &says, g, out), ENVSH_ERR_ARGUMENT);
        assert_int_equal(envsh_illuminate(maps, list, count, box, draw_fails, &says, NULL, out), ENVSH_ERR_ARGUMENT);
        assert_int_equal(envsh_illuminate(maps, NULL, count, box, draw_fails, &says, g, out), ENVSH_ERR_ARGUMENT);
        assert_int_equal(envsh_maps_create(NULL, 0, &none), ENVSH_OK);
        assert_int_equal(envsh_illuminate(none, list, count, box, draw_fails, &says, g, out), ENVSH_ERR_ARGUMENT);
        envsh_maps_free(none);
        assert_int_equal(envsh_illuminate(maps, list, count, box, draw_fails, &says, g, out), ENVSH_ERR_MESH);
        assert_true(out[0] >= 7 && out[0] <= 7);
        q = good_query;                                         /* the query is looked at before anything is drawn */
        q.bias = -1;
        assert_int_equal(envsh_illuminate(maps, list, count, box, draw_fails, &says, &q, out), ENVSH_ERR_ARGUMENT);
        assert_int_equal(envsh_illuminate(maps, list, count, box, draw_fails, &says, g, NULL), ENVSH_ERR_ARGUMENT);
        says = ENVSH_OK;
        assert_true(out[0] >= 7 && out[0] <= 7);
        assert_int_equal(envsh_illuminate(maps, NULL, 0, box, draw_fails, &says, g, out), ENVSH_OK);
        assert_true(out[0] >= 0 && out[0] <= 0);                /* no lights, no light */
        out[0] = 7;
        assert_int_equal(envsh_maps_begin(maps, list, count, box), ENVSH_OK);
        assert_int_equal(envsh_maps_end(maps), ENVSH_OK);
    }
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
    assert_int_equal(envsh_cost_fit(8, sizes, NULL, 2, &cost), 0);
    assert_int_equal(envsh_cost_fit(8, sizes, ms, 2, NULL), 0);
    assert_int_equal(envsh_cost_fit(0, sizes, ms, 2, &cost), 0);
    ms[0] = 1e12;
    assert_int_equal(envsh_cost_fit(8, sizes, ms, 2, &cost), 0);
    cost.pass = cost.slot = 1;
    assert_int_equal(envsh_cluster_size(&cost, 0, 8), 1);
    assert_int_equal(envsh_cluster_size(&cost, 8, 0), 1);
    {
        const float tile[64] = { 0 };
        const envsh_view *v = envsh_maps_views(maps, NULL);
        q = good_query;
        q.taps = 65;
        assert_true(envsh_visibility_twin(NULL, tile, 8, 1, 8, &good_query, p, n, 0) <= 0);
        assert_true(envsh_visibility_twin(v, NULL, 8, 1, 8, &good_query, p, n, 0) <= 0);
        assert_true(envsh_visibility_twin(v, tile, 8, 1, 8, NULL, p, n, 0) <= 0);
        assert_true(envsh_visibility_twin(v, tile, 8, 1, 8, &good_query, NULL, n, 0) <= 0);
        assert_true(envsh_visibility_twin(v, tile, 8, 1, 8, &good_query, p, NULL, 0) <= 0);
        assert_true(envsh_visibility_twin(v, tile, 8, 1, 8, &q, p, n, 0) <= 0);
    }
}

/* Times by which passes, or lights, would cost less than nothing: the other of the two explains all, by least squares
   of relative errors. */
static void costs_are_not_negative(void **state)
{
    uint32_t sizes[2] = { 1, 192 };
    double ms[2] = { 100, 150 };
    envsh_cost cost;
    (void)state;
    assert_int_equal(envsh_cost_fit(192, sizes, ms, 2, &cost), 1);
    assert_true(cost.pass >= 0 && cost.pass <= 0);
    assert_true(fabs(cost.slot - (1 / 100.0 + 1 / 150.0) / (192 * (1 / 1e4 + 1 / 22500.0))) < 1e-6);
    sizes[0] = 100;
    ms[0] = 220;
    ms[1] = 100;
    assert_int_equal(envsh_cost_fit(192, sizes, ms, 2, &cost), 1);
    assert_true(cost.slot >= 0 && cost.slot <= 0);
    assert_true(fabs(cost.pass - (2 / 220.0 + 1 / 100.0) / (4 / 48400.0 + 1 / 1e4)) < 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(maps_are_checked),
        cmocka_unit_test(odd_maps_work),
        cmocka_unit_test(lights_are_checked),
        cmocka_unit_test(atlas_is_checked),
        cmocka_unit_test(drawing_is_checked),
        cmocka_unit_test(transforms_move_meshes),
        cmocka_unit_test(points_move_by_the_wider_side),
        cmocka_unit_test(bad_geometry_is_harmless),
        cmocka_unit_test(far_below_a_roof_it_is_dark),
        cmocka_unit_test(every_call_of_progress_may_cancel),
        cmocka_unit_test(queries_are_checked),
        cmocka_unit_test(costs_are_not_negative),
        cmocka_unit_test(odd_lights_are_exported),
        cmocka_unit_test(any_point_has_a_direction),
        cmocka_unit_test(turning_often_keeps_extents),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
