/* bright_light_test - the brightest light that each header says it takes lights in proportion, and what is brighter is
   refused, or counted and left out: nothing is infinite, not a number, or silently wrong. */
#include "lightsampling.h"
#include "shadowfield.h"
#include "envlights.h"
#include "envshadow.h"
#include "rsm.h"
#include "ism.h"
#include "gifilter.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const float origin[3] = { 0, 0, 0 }, above[3] = { 0, 1, 0 }, up[3] = { 0, 1, 0 }, down[3] = { 0, -1, 0 };

/* Whether light by `value` is that of `one`, times value: single digits of floats may differ. */
static void in_proportion(double light, double one, double value)
{
    if (!(one > 0) || !(fabs(light / value - one) <= 1e-4 * one))
        fail_msg("%g from a light of %g, %g from one of 1", light, value, one);
}

/* Radiance of a white point under a lamp, half of whose samples are hidden; -1 if the lamp is refused. */
static double by_lightsampling(lsamp_light_kind kind, float value)
{
    enum { SAMPLES = 64 };
    static double memory[2048];
    float directions[3 * SAMPLES], distances[SAMPLES], weights[3 * SAMPLES], visible[SAMPLES], e[3] = { 0, 0, 0 };
    const lsamp_samples samples = { directions, distances, NULL, weights };
    lsamp_light_desc d;
    lsamp_material white;
    lsamp_points points;
    lsamp_sample_desc s;
    lsamp_light *light;
    int i;
    memset(&d, 0, sizeof d);
    memset(&white, 0, sizeof white);
    memset(&points, 0, sizeof points);
    memset(&s, 0, sizeof s);
    d.kind = kind;
    d.radiance[0] = d.radiance[1] = d.radiance[2] = value;
    d.position[1] = 2;
    d.direction[1] = kind == LSAMP_LIGHT_SUN ? 1 : -1;
    d.radius = 0.5f;
    d.u[0] = d.v[2] = 2;
    d.cone_half_angle = 1;
    white.diffuse[0] = white.diffuse[1] = white.diffuse[2] = 1;
    points.count = 1;
    points.positions = origin;
    points.normals = up;
    points.materials = &white;
    s.sample_count = SAMPLES;
    assert_true(sizeof memory >= 512);
    if (lsamp_light_init(&d, memory, sizeof memory, &light, NULL) != LSAMP_OK) return -1;
    assert_int_equal(lsamp_sample(&s, light, &points, &samples, NULL), LSAMP_OK);
    for (i = 0; i < SAMPLES; i++) visible[i] = (float)(i & 1);
    assert_int_equal(lsamp_accumulate(1, SAMPLES, weights, visible, e, 0), LSAMP_OK);
    return (double)e[0];
}

static void lamps_of_1e30_are_the_brightest_that_are_sampled(void **state)
{
    int kind;
    (void)state;
    for (kind = LSAMP_LIGHT_ENVIRONMENT; kind <= LSAMP_LIGHT_SPHERE; kind++) {
        in_proportion(by_lightsampling((lsamp_light_kind)kind, 1e30f), by_lightsampling((lsamp_light_kind)kind, 1),
                      1e30);
        assert_true(by_lightsampling((lsamp_light_kind)kind, 1.01e30f) < 0);
        assert_true(by_lightsampling((lsamp_light_kind)kind, 3e38f) < 0);
    }
}

/* Irradiance of a point by k suns of this irradiance straight above; -1 if they are refused. */
static double by_envshadow(float value)
{
    enum { K = 64 };
    static const float corners[9] = { 5, 1, 5, 6, 1, 5, 6, 1, 6 };
    const envsh_mesh mesh = { corners, 3, 0, NULL, 0, NULL, NULL, NULL };
    const envsh_points points = { 1, origin, 0, up, 0, NULL, 0, 0 };
    float directions[3 * K], irradiances[3 * K], e[3] = { -1, -1, -1 };
    const envsh_lights lights = { K, directions, irradiances, NULL, NULL, 0 };
    envsh_maps *maps;
    int i;
    for (i = 0; i < 3 * K; i++) {
        directions[i] = up[i % 3];
        irradiances[i] = value;
    }
    assert_int_equal(envsh_maps_create(NULL, K, &maps), ENVSH_OK);
    if (envsh_maps_begin(maps, &lights, envsh_bounds_of(&mesh, 1, NULL)) == ENVSH_OK) {
        assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_OK);
        assert_int_equal(envsh_maps_end(maps), ENVSH_OK);
        assert_int_equal(envsh_shade(maps, NULL, &points, e), ENVSH_OK);
    }
    envsh_maps_free(maps);
    return (double)e[0];
}

static void suns_of_1e32_are_the_brightest_that_have_maps(void **state)
{
    (void)state;
    in_proportion(by_envshadow(1e32f), by_envshadow(1), 1e32);
    assert_true(by_envshadow(1.01e32f) < 0 && by_envshadow(3e38f) < 0 && by_envshadow(INFINITY) < 0);
}

/* Irradiance of a sky's lights on the ground; *bad: texels that were left out. */
static double by_envlights(float value, uint64_t *bad)
{
    enum { W = 16, H = 8 };
    float texels[3 * W * H];
    const envlt_map map = { ENVLT_PROJECTION_LATLONG, W, H, texels, 0 };
    const envlt_light *list;
    envlt_lights *lights;
    envlt_stats stats;
    double sum = 0;
    uint32_t count, i;
    for (i = 0; i < 3 * W * H; i++) texels[i] = value;
    assert_int_equal(envlt_create(NULL, &map, &lights, &stats), ENVLT_OK);
    list = envlt_get_lights(lights, &count);
    for (i = 0; i < count; i++) {
        /* what envlights.h makes, envshadow.h takes */
        assert_true(list[i].irradiance[0] <= 1e32f);
        if (list[i].direction[1] > 0) sum += (double)list[i].direction[1] * (double)list[i].irradiance[0];
    }
    *bad = stats.bad_texels;
    envlt_free(lights);
    return sum;
}

static void skies_of_1e30_are_the_brightest_that_become_lights(void **state)
{
    uint64_t bad;
    const double one = by_envlights(1, &bad);
    (void)state;
    in_proportion(by_envlights(1e30f, &bad), one, 1e30);
    assert_true(bad == 0);
    assert_true(by_envlights(1.01e30f, &bad) <= 0 && bad == 128);
}

static double by_ism(float value, uint64_t *bad)
{
    enum { N = 8 };
    float positions[3 * N * N], normals[3 * N * N], fluxes[3 * N * N], e[3] = { -1, -1, -1 };
    ism_source source;
    ism_points points;
    ism_frame frame;
    ism_desc desc;
    ism_maps *maps;
    ism_stats stats;
    int i, k;
    memset(&source, 0, sizeof source);
    memset(&points, 0, sizeof points);
    memset(&frame, 0, sizeof frame);
    memset(&desc, 0, sizeof desc);
    for (i = 0; i < N * N; i++)
        for (k = 0; k < 3; k++) {
            positions[3 * i + k] = k == 1 ? 0 : (float)(k ? i / N : i % N) / N - 0.5f;
            normals[3 * i + k] = up[k];
            fluxes[3 * i + k] = value;
        }
    source.width = source.height = N;
    source.positions = positions;
    source.normals = normals;
    source.fluxes = fluxes;
    points.count = 1;
    points.positions = above;
    points.normals = down;
    frame.sources = &source;
    frame.source_count = 1;
    frame.points = &points;
    desc.vpl_count = 64;
    assert_int_equal(ism_create(&desc, &maps), ISM_OK);
    assert_int_equal(ism_render(maps, &frame, NULL, e, &stats), ISM_OK);
    *bad = stats.bad_pvpls;
    ism_free(maps);
    return (double)e[0];
}

static void fluxes_of_1e30_are_the_brightest_that_bounce(void **state)
{
    uint64_t bad;
    const double one = by_ism(1, &bad);
    (void)state;
    in_proportion(by_ism(1e28f, &bad), one, 1e28);
    assert_true(by_ism(1e30f, &bad) > 0.9e30 * one && bad == 0);    /* a VPL that takes more than 1e30 is cut there */
    assert_true(by_ism(1.01e30f, &bad) == 0.0 && bad == 64);
}

/* Irradiance above a lit floor; -1 if the light is refused. */
static double by_rsm(float value)
{
    static const float corners[12] = { -1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1 };
    static const uint32_t triangles[6] = { 0, 2, 1, 0, 3, 2 };
    rsm_desc desc;
    rsm_mesh mesh;
    rsm_points points;
    rsm_map *map;
    float e[3];
    memset(&desc, 0, sizeof desc);
    memset(&mesh, 0, sizeof mesh);
    memset(&points, 0, sizeof points);
    desc.side = 32;
    desc.light.direction[1] = 1;
    desc.light.radius = 1;
    desc.light.value[0] = desc.light.value[1] = desc.light.value[2] = value;
    mesh.positions = corners;
    mesh.vertex_count = 4;
    mesh.indices = triangles;
    mesh.index_count = 6;
    mesh.albedo[0] = mesh.albedo[1] = mesh.albedo[2] = 0.5f;
    if (rsm_map_create(&desc, &map) != RSM_OK) return -1;
    assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_OK);
    assert_int_equal(rsm_finish(map, NULL), RSM_OK);
    points.count = 1;
    points.positions = above;
    points.normals = down;
    assert_int_equal(rsm_gather((const rsm_map *const *)&map, 1, NULL, &points, e, NULL), RSM_OK);
    rsm_map_free(map);
    return (double)e[0];
}

static void lights_of_1e12_are_the_brightest_that_have_reflective_maps(void **state)
{
    (void)state;
    in_proportion(by_rsm(1e12f), by_rsm(1), 1e12);
    assert_true(by_rsm(1.01e12f) < 0 && by_rsm(3e38f) < 0);
}

/* What a sun or a sky gives a point of shadowfield.h; -1 if it is refused. */
static double by_shadowfield(float value, int is_sun)
{
    const float rgb_of[3] = { value, value, value };
    float rgb[3] = { -1, -1, -1 };
    sfield_points points;
    sfield_scene *scene;
    sfield_result result;
    memset(&points, 0, sizeof points);
    points.count = 1;
    points.positions = origin;
    points.normals = up;
    points.rgb = rgb;
    assert_int_equal(sfield_scene_create(NULL, &scene), SFIELD_OK);
    result = is_sun ? sfield_scene_sun(scene, up, rgb_of) : sfield_scene_environment(scene, rgb_of, 1, 1, NULL);
    if (result == SFIELD_OK) assert_int_equal(sfield_shade(scene, &points, 1, NULL), SFIELD_OK);
    sfield_scene_free(scene);
    return (double)rgb[0];
}

static void suns_and_skies_of_1e18_are_the_brightest_of_shadow_fields(void **state)
{
    (void)state;
    in_proportion(by_shadowfield(1e18f, 1), by_shadowfield(1, 1), 1e18);
    in_proportion(by_shadowfield(1e18f, 0), by_shadowfield(1, 0), 1e18);
    assert_true(by_shadowfield(1.01e18f, 1) < 0 && by_shadowfield(3e38f, 1) < 0);
    in_proportion(by_shadowfield(3e38f, 0), by_shadowfield(1, 0), 1e18);    /* skies are cut off there */
}

static double by_gifilter(float value)
{
    enum { SIDE = 4, PIXELS = SIDE * SIDE };
    float positions[3 * PIXELS], normals[3 * PIXELS], light[3 * PIXELS];
    gifilt_desc desc;
    gifilt_frame frame;
    gifilt_points points;
    gifilt_filter *filter;
    int i;
    memset(&desc, 0, sizeof desc);
    memset(&frame, 0, sizeof frame);
    memset(&points, 0, sizeof points);
    for (i = 0; i < 3 * PIXELS; i++) {
        positions[i] = i % 3 == 0 ? (float)(i / 3 % SIDE) : i % 3 == 1 ? (float)(i / 3 / SIDE) : 0;
        normals[i] = i % 3 == 2 ? 1.0f : 0.0f;
        light[i] = value;
    }
    desc.width = desc.height = SIDE;
    points.count = PIXELS;
    points.positions = positions;
    points.normals = normals;
    assert_int_equal(gifilt_create(&desc, &filter), GIFILT_OK);
    assert_int_equal(gifilt_apply(filter, &frame, &points, light, light), GIFILT_OK);
    gifilt_free(filter);
    return (double)light[3 * 5];
}

static void light_of_1e30_is_the_brightest_that_is_filtered(void **state)
{
    (void)state;
    in_proportion(by_gifilter(1e30f), by_gifilter(1), 1e30);
    assert_true(by_gifilter(1.01e30f) == 0.0 && by_gifilter(3e38f) == 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lamps_of_1e30_are_the_brightest_that_are_sampled),
        cmocka_unit_test(suns_of_1e32_are_the_brightest_that_have_maps),
        cmocka_unit_test(skies_of_1e30_are_the_brightest_that_become_lights),
        cmocka_unit_test(fluxes_of_1e30_are_the_brightest_that_bounce),
        cmocka_unit_test(lights_of_1e12_are_the_brightest_that_have_reflective_maps),
        cmocka_unit_test(suns_and_skies_of_1e18_are_the_brightest_of_shadow_fields),
        cmocka_unit_test(light_of_1e30_is_the_brightest_that_is_filtered),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
