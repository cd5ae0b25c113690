/* errors_test - bad input: a specific error with outputs untouched, or finite
   results. */

#include "envlights.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"

#define NOT_A_NUMBER NAN
#define INF INFINITY

static char untouched;
#define UNTOUCHED ((void *)&untouched)
static sky day;
static envlt_lights *good;
static const envlt_light *list;
static uint32_t count;

static int setup(void **state)
{
    (void)state;
    day = sky_alloc(ENVLT_PROJECTION_LATLONG, 32, 16);
    sky_fill(&day, sunny);
    if (envlt_create(NULL, &day.map, &good, NULL) != ENVLT_OK) return -1;
    list = envlt_get_lights(good, &count);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    envlt_free(good);
    sky_free(&day);
    return 0;
}

static void expect_build(envlt_result expected, const envlt_desc *d, const envlt_map *map)
{
    envlt_lights *l = (envlt_lights *)UNTOUCHED;
    envlt_stats stats, before;
    memset(&stats, 0x31, sizeof stats);
    before = stats;
    assert_int_equal(envlt_create(d, map, &l, &stats), expected);
    if (expected == ENVLT_OK) {
        for (int c = 0; c < 3; c++) assert_true(stats.energy[c] >= 0 && stats.energy[c] < 1e32);
        envlt_free(l);
        return;
    }
    assert_ptr_equal(l, UNTOUCHED);
    assert_memory_equal(&stats, &before, sizeof stats);
}

static void maps_are_checked(void **state)
{
    envlt_map m = day.map;
    envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, 0);
    (void)state;
    assert_int_equal(envlt_create(NULL, &m, NULL, NULL), ENVLT_ERR_ARGUMENT);
    expect_build(ENVLT_ERR_ARGUMENT, NULL, NULL);
    expect_build(ENVLT_OK, NULL, &m);
    m.rgb = NULL;
    expect_build(ENVLT_ERR_ARGUMENT, NULL, &m);
    m = day.map;
    m.width = 0;
    expect_build(ENVLT_ERR_ARGUMENT, NULL, &m);
    m = day.map;
    m.projection = (envlt_projection)9;
    expect_build(ENVLT_ERR_INPUT, NULL, &m);
    m.projection = ENVLT_PROJECTION_CUBE;
    expect_build(ENVLT_ERR_ARGUMENT, NULL, &m);       /* 32 x 16 is no cube's face */
    m = day.map;
    m.texel_stride = 8;
    expect_build(ENVLT_ERR_ARGUMENT, NULL, &m);
    m.texel_stride = 14;
    expect_build(ENVLT_ERR_ARGUMENT, NULL, &m);
    m.texel_stride = SIZE_MAX & ~(size_t)3;
    expect_build(ENVLT_ERR_LIMIT, NULL, &m);
    m = day.map;
    m.height = 0;
    expect_build(ENVLT_ERR_ARGUMENT, NULL, &m);
    m.height = (1u << 27) + 1;
    m.width = 1;
    expect_build(ENVLT_ERR_LIMIT, NULL, &m);
    m = day.map;
    m.width = m.height = 65536;
    expect_build(ENVLT_ERR_LIMIT, NULL, &m);
    m.width = UINT32_MAX;
    expect_build(ENVLT_ERR_LIMIT, NULL, &m);
    d.light_count = ENVLT_MAX_LIGHTS + 1;
    expect_build(ENVLT_ERR_DESC, &d, &day.map);
    d = desc_of((envlt_method)17, 5);
    expect_build(ENVLT_ERR_DESC, &d, &day.map);
    d = desc_of(ENVLT_METHOD_DEFAULT, 5);
    d.system.allocator.alloc_fn = ledger_alloc;
    expect_build(ENVLT_ERR_DESC, &d, &day.map);
}

/* Sizes and contents that are odd but allowed. */
static void odd_maps_work(void **state)
{
    static const uint32_t sizes[][2] = { { 1, 1 }, { 1, 9 }, { 9, 1 }, { 2, 2 }, { 3, 7 }, { 37, 5 } };
    (void)state;
    for (int m = 1; m < ENVLT_METHOD_COUNT; m++)
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++)
            for (int content = 0; content < 5; content++)
                for (uint32_t k = 1; k < 40; k += 13) {
                    int cube = sizes[i][0] == sizes[i][1];
                    sky s = sky_alloc(cube ? ENVLT_PROJECTION_CUBE : ENVLT_PROJECTION_LATLONG, sizes[i][0],
                                      sizes[i][1]);
                    envlt_desc d = desc_of((envlt_method)m, k);
                    envlt_lights *l;
                    const envlt_light *out;
                    uint32_t n;
                    d.split_sun = content & 1;
                    d.hemisphere = content == 2;
                    for (size_t t = 0; t < 3 * s.texels; t++)
                        s.rgb[t] = content == 0 ? 0 : content == 1 ? 1e30f : content == 2 ? 1 : content == 3 ? 1e-38f
                                                                                            : NOT_A_NUMBER;
                    assert_int_equal(envlt_create(&d, &s.map, &l, NULL), ENVLT_OK);
                    out = envlt_get_lights(l, &n);
                    assert_in_range(n, content == 0 || content == 4 ? 0 : 1, content == 0 || content == 4 ? 0 : k);
                    for (uint32_t j = 0; j < n; j++) assert_true(light_is_finite(&out[j]));
                    assert_int_equal(envlt_follow(l, &s.map, k + 1, NULL), ENVLT_OK);
                    envlt_free(l);
                    sky_free(&s);
                }
}

static void lights_are_checked(void **state)
{
    envlt_light copy[128];
    envlt_map other = day.map;
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
    assert_null(envlt_get_lights(NULL, &n));
    assert_int_equal(n, 0);
    assert_null(envlt_strata(NULL, &texels));
    assert_int_equal(texels, 0);
    envlt_free(NULL);
    assert_int_equal(envlt_jitter(NULL, 0, 0, copy), ENVLT_ERR_ARGUMENT);
    assert_int_equal(envlt_jitter(good, 0, 0, NULL), ENVLT_ERR_ARGUMENT);
    assert_int_equal(envlt_follow(NULL, &day.map, 0, NULL), ENVLT_ERR_ARGUMENT);
    assert_int_equal(envlt_follow(good, NULL, 0, NULL), ENVLT_ERR_ARGUMENT);
    assert_int_equal(envlt_follow(good, &day.map, ENVLT_MAX_LIGHTS + 1, NULL), ENVLT_ERR_ARGUMENT);
    other.width = 16;
    assert_int_equal(envlt_follow(good, &other, 0, NULL), ENVLT_ERR_MISMATCH);
    assert_int_equal(envlt_residual_sh(good, &other, sh), ENVLT_ERR_MISMATCH);
    other = day.map;
    other.height = 8;
    assert_int_equal(envlt_follow(good, &other, 0, NULL), ENVLT_ERR_MISMATCH);
    assert_int_equal(envlt_residual_sh(good, &other, sh), ENVLT_ERR_MISMATCH);
    other = day.map;
    other.projection = ENVLT_PROJECTION_CUBE;
    other.height = 32;                              /* as wide, but six faces */
    assert_int_equal(envlt_follow(good, &other, 0, NULL), ENVLT_ERR_MISMATCH);
    assert_int_equal(envlt_residual_sh(good, &other, sh), ENVLT_ERR_MISMATCH);
    other.rgb = NULL;
    assert_int_equal(envlt_follow(good, &other, 0, NULL), ENVLT_ERR_ARGUMENT);
    assert_int_equal(envlt_match(NULL, 1, copy, count), ENVLT_ERR_ARGUMENT);
    assert_int_equal(envlt_match(list, count, NULL, 1), ENVLT_ERR_ARGUMENT);
    assert_int_equal(envlt_match(NULL, 0, copy, count), ENVLT_OK);
    assert_int_equal(envlt_rotate(copy, count, NULL), ENVLT_ERR_ARGUMENT);
    m[0] = 2;
    assert_int_equal(envlt_rotate(copy, count, m), ENVLT_ERR_INPUT);
    m[0] = m[5] = m[10] = 2;                        /* even, but no rotation */
    assert_int_equal(envlt_rotate(copy, count, m), ENVLT_ERR_INPUT);
    assert_int_equal(envlt_rotate(NULL, 1, m), ENVLT_ERR_ARGUMENT);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        memset(m, 0, sizeof m);
        m[0] = m[5] = m[10] = m[15] = 1;
        assert_int_equal(envlt_rotate(copy, count, m), ENVLT_OK);
        m[wrong[i].at] = wrong[i].value;
        assert_int_equal(envlt_rotate(copy, count, m), ENVLT_ERR_INPUT);
    }
    memset(text, 'x', sizeof text);
    assert_int_equal(envlt_gltf_bytes(NULL, 0), 0);
    assert_int_equal(envlt_gltf_write(NULL, 0, text, sizeof text), ENVLT_ERR_ARGUMENT);
    assert_int_equal(envlt_gltf_write(list, 1, NULL, 9), ENVLT_ERR_ARGUMENT);
    assert_true(envlt_gltf_bytes(list, 0) > 8);
    assert_int_equal(envlt_gltf_write(list, 0, text, sizeof text), ENVLT_ERR_MEMORY);
    assert_int_equal(text[0], 'x');
    rest = (float *)malloc(3 * day.texels * sizeof *rest);
    assert_non_null(rest);
    assert_int_equal(envlt_residual(good, &day.map, NULL), ENVLT_ERR_ARGUMENT);
    assert_int_equal(envlt_residual(NULL, &day.map, rest), ENVLT_ERR_ARGUMENT);
    assert_int_equal(envlt_residual_sh(good, &day.map, NULL), ENVLT_ERR_ARGUMENT);
    assert_int_equal(envlt_residual_sh(good, NULL, sh), ENVLT_ERR_ARGUMENT);
    other = day.map;
    other.rgb = NULL;
    assert_int_equal(envlt_residual_sh(good, &other, sh), ENVLT_ERR_ARGUMENT);
    assert_int_equal(envlt_match(NULL, 0, NULL, 0), ENVLT_OK);
    assert_int_equal(envlt_rotate(NULL, 0, (const float[16]){ 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }),
                     ENVLT_OK);
    assert_null(envlt_get_lights(NULL, NULL));
    assert_ptr_equal(envlt_get_lights(good, NULL), list);
    assert_null(envlt_strata(NULL, NULL));
    assert_non_null(envlt_strata(good, NULL));
    free(rest);
    assert_string_equal(envlt_result_text((envlt_result)99), "unknown result");
    assert_string_equal(envlt_result_text(ENVLT_OK), "ok");
    assert_true(envlt_texel_solid_angle(ENVLT_PROJECTION_LATLONG, 4, 4, 4, 0) <= 0);
    assert_true(envlt_texel_solid_angle(ENVLT_PROJECTION_LATLONG, 4, 4, 0, 4) <= 0);
}

/* A light that shines down -Z has no shortest turn from +Z; colours of black are white times nothing; large numbers. */
static double dot3(const float *a, const float *b)
{
    return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

static void odd_lights_are_exported(void **state)
{
    envlt_light l[2];
    char text[1000];
    (void)state;
    memset(l, 0, sizeof l);
    l[0].direction[2] = -1;
    l[0].irradiance[0] = l[0].irradiance[1] = 2.5e20f;
    l[0].irradiance[2] = 5e20f;
    l[1].direction[2] = 1;
    assert_int_equal(envlt_gltf_write(l, 2, text, sizeof text), ENVLT_OK);
    assert_non_null(strstr(text, "\"color\":[5.00000000e-1,5.00000000e-1,1.00000000e0],"
                                 "\"intensity\":5.00000010e20}"));          /* what 5e20f is */
    assert_non_null(strstr(text, "\"color\":[1.00000000e0,1.00000000e0,1.00000000e0],\"intensity\":0}"));
    assert_non_null(strstr(text, "{\"rotation\":[1.00000000e0,0,0,0]"));
    assert_non_null(strstr(text, "0,0,1.00000000e0]"));
    l[0].irradiance[1] = INF;                       /* JSON has no word for these, and no end of their digits came */
    l[0].irradiance[2] = NOT_A_NUMBER;
    l[1].irradiance[0] = -INF;
    l[1].direction[0] = INF;
    assert_int_equal(envlt_gltf_write(l, 2, text, sizeof text), ENVLT_OK);
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
            envlt_projection p = cube ? ENVLT_PROJECTION_CUBE : ENVLT_PROJECTION_LATLONG;
            envlt_texel_direction(p, 8, 8, 4, odd[i / 8], odd[i % 8], d);
            CLOSE(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], 1, 1e-6);
        }
    for (int turn = -2; turn <= 2; turn++) {            /* whole turns of the azimuth are none */
        envlt_texel_direction(ENVLT_PROJECTION_LATLONG, 16, 8, 0, 3.25f, 2.5f, d);
        envlt_texel_direction(ENVLT_PROJECTION_LATLONG, 16, 8, 0, 3.25f + 16 * (float)turn, 2.5f, turned);
        for (int c = 0; c < 3; c++) CLOSE(d[c], turned[c], 1e-6);
    }
}

/* A rotation that is a thousandth too long is allowed; done every frame, it must not blow lights up. */
static void turning_often_keeps_extents(void **state)
{
    const float s = 1.0009f, m[16] = { 0, 0, -s, 0, 0, s, 0, 0, s, 0, 0, 0, 0, 0, 0, 1 };
    envlt_light l = list[0];
    (void)state;
    for (int i = 0; i < 4000; i++) assert_int_equal(envlt_rotate(&l, 1, m), ENVLT_OK);
    for (int c = 0; c < 3; c++) {
        CLOSE(l.direction[c], list[0].direction[c], 1e-4);
        CLOSE(l.axis_u[c], list[0].axis_u[c], 1e-3 * sqrt(dot3(list[0].axis_u, list[0].axis_u)));
        CLOSE(l.axis_v[c], list[0].axis_v[c], 1e-3 * sqrt(dot3(list[0].axis_u, list[0].axis_u)));
    }
}

static char logged[300];

static void keep(void *user, const char *message)
{
    snprintf((char *)user, sizeof logged, "%s", message);
}

/* One line that names function, field, value and range. */
static void failed_calls_say_why(void **state)
{
    envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, ENVLT_MAX_LIGHTS + 1);
    envlt_map m = day.map;
    envlt_lights *l;
    float rest[27];                                 /* nothing is written */
    (void)state;
    d.system.log = keep;
    d.system.user = logged;
    assert_int_equal(envlt_create(&d, &m, &l, NULL), ENVLT_ERR_DESC);
    assert_string_equal(logged, "envlt_create: desc.light_count is 8193; it must be 0 (= 128) or 1..8192");
    d.light_count = 10;
    m.texel_stride = 14;
    assert_int_equal(envlt_create(&d, &m, &l, NULL), ENVLT_ERR_ARGUMENT);
    assert_string_equal(logged, "envlt_create: map.texel_stride is 14; it must be 0, or a multiple of 4 from 12 on");
    assert_int_equal(envlt_create(&d, &day.map, &l, NULL), ENVLT_OK);
    m = day.map;
    m.width = 8;
    assert_int_equal(envlt_follow(l, &m, 0, NULL), ENVLT_ERR_MISMATCH);
    assert_string_equal(logged, "envlt_follow: map.width is 8; it must be 32, as that of the map before");
    m.width = 0;
    assert_int_equal(envlt_residual(l, &m, rest), ENVLT_ERR_ARGUMENT);
    assert_string_equal(logged, "envlt_residual: map.width is 0; it must be 1 or more");
    m = day.map;
    m.height = 0;
    assert_int_equal(envlt_residual_sh(l, &m, rest), ENVLT_ERR_ARGUMENT);
    assert_string_equal(logged, "envlt_residual_sh: map.height is 0; it must be 1 or more");
    m.height = 17;
    assert_int_equal(envlt_residual_sh(l, &m, rest), ENVLT_ERR_MISMATCH);
    assert_string_equal(logged, "envlt_residual_sh: map.height is 17; it must be 16, as that of the map before");
    assert_int_equal(envlt_residual(l, &day.map, NULL), ENVLT_ERR_ARGUMENT);
    assert_string_equal(logged, "envlt_residual: rgb is NULL");
    assert_int_equal(envlt_residual_sh(l, &day.map, NULL), ENVLT_ERR_ARGUMENT);
    assert_string_equal(logged, "envlt_residual_sh: sh is NULL");
    assert_int_equal(envlt_follow(l, NULL, 0, NULL), ENVLT_ERR_ARGUMENT);
    assert_string_equal(logged, "envlt_follow: map is NULL");
    assert_int_equal(envlt_follow(l, &day.map, ENVLT_MAX_LIGHTS + 1, NULL), ENVLT_ERR_ARGUMENT);
    assert_string_equal(logged, "envlt_follow: light_count is 8193; it must be 0 (as before) or 1..8192");
    assert_int_equal(envlt_jitter(l, 0, 0, NULL), ENVLT_ERR_ARGUMENT);
    assert_string_equal(logged, "envlt_jitter: out is NULL");
    envlt_free(l);
    m = day.map;
    m.width = 16;                                   /* a square, which might be a cube's face */
    assert_int_equal(envlt_create(&d, &m, &l, NULL), ENVLT_OK);
    m.projection = ENVLT_PROJECTION_CUBE;
    m.height = m.width = 16;
    assert_int_equal(envlt_follow(l, &m, 0, NULL), ENVLT_ERR_MISMATCH);
    assert_string_equal(logged, "envlt_follow: map.projection is not that of the map before");
    envlt_free(l);
}

/* Each of the other refusals of envlt_create names the field, its value and its range. */
static void refused_maps_are_named(void **state)
{
    static float texel[3];
    const struct {
        envlt_map map;
        envlt_result result;
        const char *text;
    } bad[] = {
        { { ENVLT_PROJECTION_LATLONG, 4, 4, NULL, 0 }, ENVLT_ERR_ARGUMENT, "map.rgb is NULL" },
        { { (envlt_projection)9, 4, 4, texel, 0 }, ENVLT_ERR_INPUT,
          "map.projection is 9; it must be one of envlt_projection" },
        { { ENVLT_PROJECTION_CUBE, 4, 5, texel, 0 }, ENVLT_ERR_ARGUMENT,
          "map.height is 5; it must be the width: faces of a cube are squares" },
        { { ENVLT_PROJECTION_LATLONG, 65536, 32768, texel, 0 }, ENVLT_ERR_LIMIT,
          "map.width x map.height is 2147483648; it must be at most 2^27, all faces of a cube together" },
        { { ENVLT_PROJECTION_CUBE, 8192, 8192, texel, 0 }, ENVLT_ERR_LIMIT,
          "map.width x map.height is 67108864; it must be at most 2^27, all faces of a cube together" },
    };
    envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, 10);
    envlt_lights *l = NULL;
    char expected[200];
    (void)state;
    d.system.log = keep;
    d.system.user = logged;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        logged[0] = 0;
        assert_int_equal(envlt_create(&d, &bad[i].map, &l, NULL), bad[i].result);
        snprintf(expected, sizeof expected, "envlt_create: %s", bad[i].text);
        assert_string_equal(logged, expected);
    }
    assert_int_equal(envlt_create(&d, NULL, &l, NULL), ENVLT_ERR_ARGUMENT);
    assert_string_equal(logged, "envlt_create: map is NULL");
    assert_int_equal(envlt_create(&d, &day.map, NULL, NULL), ENVLT_ERR_ARGUMENT);
    assert_string_equal(logged, "envlt_create: out is NULL");
    d.method = (envlt_method)17;
    assert_int_equal(envlt_create(&d, &day.map, &l, NULL), ENVLT_ERR_DESC);
    assert_string_equal(logged, "envlt_create: desc.method is 17; it must be one of envlt_method");
    d.method = ENVLT_METHOD_DEFAULT;
    d.system.allocator.alloc_fn = ledger_alloc;
    assert_int_equal(envlt_create(&d, &day.map, &l, NULL), ENVLT_ERR_DESC);
    assert_string_equal(logged, "envlt_create: desc.system.allocator has one of its two functions");
    assert_null(l);
}

static double length_of(const float *d) { return sqrt(dot3(d, d)); }

/* Lights that are built, followed, jittered and turned, by every method, have unit directions. */
static void directions_that_are_made_are_unit(void **state)
{
    static const float turn[16] = { 0.6f, 0, -0.8f, 0, 0, 1, 0, 0, 0.8f, 0, 0.6f, 0, 0, 0, 0, 1 };
    (void)state;
    for (int cube = 0; cube < 2; cube++)
        for (int m = 1; m < ENVLT_METHOD_COUNT; m++) {
            sky s = sky_alloc(cube ? ENVLT_PROJECTION_CUBE : ENVLT_PROJECTION_LATLONG, 24, cube ? 24 : 12);
            envlt_desc d = desc_of((envlt_method)m, 40);
            envlt_light turned[46], moved[46];
            const envlt_light *made;
            envlt_lights *l;
            uint32_t n;
            sky_fill(&s, sunny);
            assert_int_equal(envlt_create(&d, &s.map, &l, NULL), ENVLT_OK);
            sky_fill(&s, studio);
            assert_int_equal(envlt_follow(l, &s.map, 0, NULL), ENVLT_OK);
            made = envlt_get_lights(l, &n);
            assert_in_range(n, 10, 46);
            assert_int_equal(envlt_jitter(l, 3, 1, moved), ENVLT_OK);
            memcpy(turned, made, n * sizeof *turned);
            for (int i = 0; i < 100; i++) assert_int_equal(envlt_rotate(turned, n, turn), ENVLT_OK);
            for (uint32_t i = 0; i < n; i++) {
                CLOSE(length_of(made[i].direction), 1, 1e-6);
                CLOSE(length_of(moved[i].direction), 1, 1e-6);
                CLOSE(length_of(turned[i].direction), 1, 1e-6);
            }
            envlt_free(l);
            sky_free(&s);
        }
}

/* Lengths from 0.97 to 1.03 are unit; others are refused, and nothing is written then. */
static void directions_that_are_given_must_be_unit(void **state)
{
    static const float lengths[] = { 0.971f, 1.029f, 0, 0.969f, 1.031f, 0.5f, 2, 1e-20f };
    static const float still[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    envlt_light two[2], before[2];
    char text[1000];
    (void)state;
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        const envlt_result expected = i < 3 ? ENVLT_OK : ENVLT_ERR_INPUT;
        memset(two, 0, sizeof two);
        two[0].direction[1] = 1;
        two[1].direction[2] = lengths[i];
        memcpy(before, two, sizeof two);
        strcpy(text, "x");
        assert_int_equal(envlt_gltf_write(two, 2, text, sizeof text), expected);
        assert_true((text[0] == 'x') == (i >= 3));
        assert_int_equal(envlt_match(list, 2, two, 2), expected);
        if (i >= 3) assert_memory_equal(two, before, sizeof two);
        memcpy(two, before, sizeof two);
        assert_int_equal(envlt_match(two, 2, before, 1), expected);
        assert_int_equal(envlt_rotate(two, 2, still), expected);
        if (i >= 3) assert_memory_equal(two, before, sizeof two[0]);
    }
}

static size_t left;                     /* allocations that succeed until the next one fails */

static void *some_memory(size_t bytes, void *user)
{
    (void)user;
    if (!left) return NULL;
    left--;
    return malloc(bytes);
}

static void back(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Whichever allocation fails, the log says so, once. */
static void missing_memory_is_told(void **state)
{
    envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, 10);
    envlt_lights *l = NULL;
    envlt_result result = ENVLT_ERR_ALLOC;
    size_t most;
    (void)state;
    d.system.log = keep;
    d.system.user = logged;
    d.system.allocator.alloc_fn = some_memory;
    d.system.allocator.free_fn = back;
    for (most = 0; result != ENVLT_OK; most++) {
        logged[0] = 0;
        left = most;
        result = envlt_create(&d, &day.map, &l, NULL);
        if (result != ENVLT_OK) assert_string_equal(logged, "envlt_create: system.allocator returned no memory");
    }
    assert_true(most > 5);
    left = 0;
    assert_int_equal(envlt_follow(l, &day.map, 0, NULL), ENVLT_ERR_ALLOC);
    assert_string_equal(logged, "envlt_follow: system.allocator returned no memory");
    envlt_free(l);
}

/* After a black map all lights are built anew, and the log names the call that the user made. */
static void missing_memory_after_a_black_map_is_told(void **state)
{
    envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, 10);
    sky night = sky_alloc(ENVLT_PROJECTION_LATLONG, 32, 16);
    envlt_lights *l = NULL;
    (void)state;
    d.system.log = keep;
    d.system.user = logged;
    d.system.allocator.alloc_fn = some_memory;
    d.system.allocator.free_fn = back;
    left = SIZE_MAX;
    assert_int_equal(envlt_create(&d, &night.map, &l, NULL), ENVLT_OK);
    left = 3;
    assert_int_equal(envlt_follow(l, &day.map, 0, NULL), ENVLT_ERR_ALLOC);
    assert_string_equal(logged, "envlt_follow: system.allocator returned no memory");
    envlt_free(l);
    sky_free(&night);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(missing_memory_is_told),
        cmocka_unit_test(missing_memory_after_a_black_map_is_told),
        cmocka_unit_test(refused_maps_are_named),
        cmocka_unit_test(directions_that_are_made_are_unit),
        cmocka_unit_test(directions_that_are_given_must_be_unit),
        cmocka_unit_test(maps_are_checked),
        cmocka_unit_test(odd_maps_work),
        cmocka_unit_test(lights_are_checked),
        cmocka_unit_test(odd_lights_are_exported),
        cmocka_unit_test(any_point_has_a_direction),
        cmocka_unit_test(turning_often_keeps_extents),
        cmocka_unit_test(failed_calls_say_why),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
