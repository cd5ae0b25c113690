/* seen_light_test - rsm_gather with the shadows of ism.h's and csm.h's maps, where the answer is known: a plate
   between lights and a plane throws shadows whose edges are a projection, and the light about them is
   flux / pi cos cos / d^2. What the functions ism_see and cohsm_see answer for lights that are not there. */
#include "csm.h"
#include "rsm.h"
#include "ism.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { SIDE = 61, POINTS = SIDE * SIDE };

/* The plate y = 1, 1 x 0.6, and a floor below the lights, which hides nothing of them. */
static const float corners[24] = { -0.5f, 1, -0.3f, -0.5f, 1, 0.3f, 0.5f, 1, 0.3f, 0.5f, 1, -0.3f,
                                   -2, 0, -2, -2, 0, 2, 2, 0, 2, 2, 0, -2 };
static const uint32_t indices[12] = { 0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7 };
static float plane[3 * POINTS], down[3 * POINTS];

static int make_plane(void **state)
{
    (void)state;
    for (int i = 0; i < POINTS; i++) {
        plane[3 * i] = 0.1f * (float)(i % SIDE) - 3;
        plane[3 * i + 1] = 2;
        plane[3 * i + 2] = 0.1f * (float)(i / SIDE) - 3;
        down[3 * i + 1] = -1;
    }
    return 0;
}

/* Where on the floor light n lies, of which each shines in a channel of its own. */
static const float places[3][2] = { { 0, 0 }, { 1.3f, -0.4f }, { -0.7f, 0.5f } };

static void make_lights(rsm_texel lights[3])
{
    memset(lights, 0, 3 * sizeof *lights);
    for (int n = 0; n < 3; n++) {
        lights[n].position[0] = places[n][0];
        lights[n].position[2] = places[n][1];
        lights[n].normal[1] = 1;
        lights[n].flux[n] = 10;
        lights[n].area = 0.01f;
    }
}

/* The exact light of light n at a point, and how far the point lies from the edge of the shadow: the
   ray passes the plate y = 1 half-way, at the mean of light and point, whose x is 0.5 at most in the shadow. */
static double exact_light(int n, const float *p, double *from_edge)
{
    double x = (double)p[0] - (double)places[n][0], z = (double)p[2] - (double)places[n][1], d2 = x * x + 4 + z * z;
    double sx = fabs((double)p[0] + (double)places[n][0]) - 1, sz = fabs((double)p[2] + (double)places[n][1]) - 0.6;
    double outside = fmax(sx, sz);
    *from_edge = fabs(outside);
    return outside > 0 ? 10 / 3.14159265358979 * 4 / (d2 * d2) : 0;
}

/* Compares all but points within `edge` of a shadow's edge, and within `texel` times the cube of their distance from
   the light, over 4: so wide does a step of that size on the hemisphere's disc, which a map of equal flux is, become in
   the plane. Returns how many lie in a shadow. */
static int is_exact(const float *light, double edge, double texel)
{
    int dark = 0, off = 0;
    for (int p = 0; p < POINTS; p++)
        for (int n = 0; n < 3; n++) {
            double from_edge, exact = exact_light(n, plane + 3 * p, &from_edge);
            double x = (double)plane[3 * p] - (double)places[n][0], z = (double)plane[3 * p + 2] - (double)places[n][1];
            if (from_edge < edge + texel * pow(x * x + 4 + z * z, 1.5) / 4) continue;
            off += !(fabs((double)light[3 * p + n] - exact) <= 1e-5 * exact);
            dark += exact <= 0;
        }
    assert_int_equal(off, 0);
    return dark;
}

static rsm_points receivers(void)
{
    rsm_points points;
    memset(&points, 0, sizeof points);
    points.count = POINTS;
    points.positions = plane;
    points.normals = down;
    return points;
}

static cohsm_maps *maps_of_lights(const rsm_texel lights[3])
{
    cohsm_mesh mesh = { corners, 8, 0, indices, 12, NULL, NULL, NULL };
    float locations[12];
    cohsm_maps *maps = NULL;
    cohsm_desc desc;
    memset(&desc, 0, sizeof desc);
    cohsm_light_locations(lights->position, sizeof *lights, lights->normal, sizeof *lights, 3, 0.001f, locations);
    assert_true(fabsf(locations[9] - 0.001f) < 1e-7f && fabsf(locations[4] - 1.3f) < 1e-7f);
    desc.domain.kind = COHSM_DOMAIN_LIST;
    desc.domain.locations = locations;
    desc.domain.location_count = 3;
    desc.map_side = 256;
    desc.order = COHSM_ORDER_SCANLINE;
    assert_int_equal(cohsm_build(&desc, &mesh, &maps, NULL), COHSM_OK);
    return maps;
}

static void a_plate_shadows_bounced_light_by_imperfect_maps(void **state)
{
    static float light[3 * POINTS];
    ism_mesh mesh = { corners, 8, 0, indices, 12, NULL, NULL, NULL, NULL, NULL };
    ism_points view;
    ism_frame frame;
    ism_source source;
    ism_desc desc;
    ism_sight sight = { NULL, 0 };
    ism_maps *maps;
    rsm_texel lights[3];
    rsm_points points = receivers();
    rsm_gather_desc gather;
    int dark, lit[3] = { 0, 0, 0 };
    (void)state;
    make_lights(lights);
    memset(&view, 0, sizeof view);
    memset(&frame, 0, sizeof frame);
    memset(&source, 0, sizeof source);
    memset(&desc, 0, sizeof desc);
    memset(&gather, 0, sizeof gather);
    view.count = POINTS;
    view.positions = plane;
    view.normals = down;
    frame.mesh = &mesh;
    frame.points = &view;
    source.width = 3;
    source.height = 1;
    source.positions = lights->position;
    source.normals = lights->normal;
    source.fluxes = lights->flux;
    source.position_stride = source.normal_stride = source.flux_stride = sizeof *lights;
    desc.vpl_count = 3;
    desc.tile_side = 128;
    desc.surfel_count = 16384;
    assert_int_equal(ism_create(&desc, &maps), ISM_OK);
    assert_int_equal(ism_set_sources(maps, &source, 1), ISM_OK);
    assert_int_equal(ism_build(maps, &frame), ISM_OK);
    sight.maps = maps;
    gather.visible_fn = ism_see;
    gather.visible_user = &sight;
    assert_int_equal(rsm_gather_list(lights, 3, &gather, &points, light, NULL), RSM_OK);
    dark = is_exact(light, 0.05, 1.5 / 64);             /* a texel and a half of 128 across */
    assert_true(dark > 3 * 100);
    for (int i = 0; i < 3; i++) {
        static const float biases[3] = { 0, -1, 0.6f };
        sight.bias = biases[i];
        for (uint32_t v = 0; v < 3; v++) {
            assert_int_equal(ism_visible(maps, v, &view, biases[i], light), ISM_OK);
            for (int p = 0; p < POINTS; p++) {
                float seen;
                ism_see(&sight, plane + 3 * p, down + 3 * p, &v, 1, &seen);
                assert_true(fabsf(seen - light[p]) <= 0);
                lit[i] += seen > 0;
            }
        }
    }
    assert_true(lit[2] > lit[0]);               /* so large a bias moves receivers before the plate */
    ism_free(maps);
}

static void a_plate_shadows_bounced_light_by_coherent_maps_at_the_lights(void **state)
{
    static float light[3 * POINTS];
    rsm_texel lights[3];
    rsm_points points = receivers();
    rsm_gather_desc gather;
    cohsm_instance instance;
    cohsm_sight sight;
    (void)state;
    make_lights(lights);
    memset(&gather, 0, sizeof gather);
    memset(&instance, 0, sizeof instance);
    memset(&sight, 0, sizeof sight);
    instance.maps = maps_of_lights(lights);
    sight.instances = &instance;
    sight.instance_count = 1;
    sight.query.light_kind = COHSM_LIGHT_INDEX;
    gather.visible_fn = cohsm_see;
    gather.visible_user = &sight;
    assert_int_equal(rsm_gather_list(lights, 3, &gather, &points, light, NULL), RSM_OK);
    assert_true(is_exact(light, 0.06, 0) > 3 * 180);
    cohsm_free((cohsm_maps *)(uintptr_t)instance.maps);
}

/* Lights that move: maps of all directions of the plate itself, asked by the lights' positions where they lie. */
static void a_plate_shadows_bounced_light_by_its_own_maps_of_directions(void **state)
{
    static float light[3 * POINTS];
    cohsm_mesh mesh = { corners, 8, 0, indices, 6, NULL, NULL, NULL };
    rsm_texel lights[3];
    rsm_points points = receivers();
    rsm_gather_desc gather;
    cohsm_instance instance;
    cohsm_sight sight;
    cohsm_maps *maps = NULL;
    cohsm_desc desc;
    (void)state;
    make_lights(lights);
    memset(&desc, 0, sizeof desc);
    memset(&gather, 0, sizeof gather);
    memset(&instance, 0, sizeof instance);
    memset(&sight, 0, sizeof sight);
    desc.order = COHSM_ORDER_HILBERT;
    desc.orientation = COHSM_ORIENTATION_POLAR;
    assert_int_equal(cohsm_build(&desc, &mesh, &maps, NULL), COHSM_OK);
    instance.maps = maps;
    sight.instances = &instance;
    sight.instance_count = 1;
    sight.query.light_kind = COHSM_LIGHT_POSITION;
    sight.query.lights = lights->position;
    sight.query.light_stride = sizeof *lights;
    gather.visible_fn = cohsm_see;
    gather.visible_user = &sight;
    assert_int_equal(rsm_gather_list(lights, 3, &gather, &points, light, NULL), RSM_OK);
    assert_true(is_exact(light, 0.12, 0) > 3 * 120);
    cohsm_free(maps);
}

static void lights_that_are_not_there_are_seen_and_what_fails_is_dark(void **state)
{
    static const float at[3] = { 0, 2, 0 }, n[3] = { 0, -1, 0 };
    uint32_t numbers[150];
    float visible[150];
    rsm_texel lights[3];
    cohsm_instance instance;
    cohsm_sight sight;
    ism_desc desc;
    ism_maps *maps;
    ism_sight by_points = { NULL, 0 };
    (void)state;
    make_lights(lights);
    for (uint32_t i = 0; i < 150; i++) numbers[i] = i < 149 ? i % 3 : 7;
    memset(&instance, 0, sizeof instance);
    memset(&sight, 0, sizeof sight);
    sight.query.light_kind = COHSM_LIGHT_INDEX;
    sight.instances = &instance;
    cohsm_see(&sight, at, n, numbers, 150, visible);            /* no instances: nothing hides anything */
    for (int i = 0; i < 150; i++) assert_true(visible[i] >= 1);
    sight.instance_count = 1;
    cohsm_see(&sight, at, n, numbers, 150, visible);            /* an instance without maps: it fails */
    for (int i = 0; i < 150; i++) assert_true(visible[i] <= 0);
    instance.maps = maps_of_lights(lights);
    cohsm_see(&sight, at, n, numbers, 150, visible);
    for (int i = 0; i < 150; i++)
        assert_true((visible[i] > 0.5f) == (i == 149 || numbers[i] == 1));      /* by the plate's projection */
    sight.query.light_kind = COHSM_LIGHT_POSITION;              /* these maps have no directions: it fails */
    sight.query.lights = lights->position;
    sight.query.light_stride = sizeof *lights;
    cohsm_see(&sight, at, n, numbers, 3, visible);
    for (int i = 0; i < 3; i++) assert_true(visible[i] <= 0);
    cohsm_free((cohsm_maps *)(uintptr_t)instance.maps);

    memset(&desc, 0, sizeof desc);
    assert_int_equal(ism_create(&desc, &maps), ISM_OK);
    by_points.maps = maps;
    ism_see(&by_points, at, n, numbers, 150, visible);          /* nothing is drawn yet */
    for (int i = 0; i < 150; i++) assert_true(visible[i] <= 0);
    ism_free(maps);
}

/* cohsm_see gives each light what cohsm_visible_scene gives it, with every filter; random numbers are each receiver's
   own, so that the mean over receivers is that of PCF. */
static void each_light_gets_what_a_query_gives(void **state)
{
    enum { LIGHTS = 100 };
    static const float n[3] = { 0, -1, 0 };
    cohsm_mesh mesh = { corners, 8, 0, indices, 6, NULL, NULL, NULL };
    float lights[3 * LIGHTS], at[3 * LIGHTS], seen[LIGHTS], expected[LIGHTS], packed[3 * LIGHTS];
    uint32_t numbers[LIGHTS];
    cohsm_instance instances[2];
    cohsm_sight sight;
    cohsm_maps *maps = NULL;
    cohsm_desc desc;
    double sum[COHSM_FILTER_COUNT] = { 0, 0, 0 };
    int refused = 0;
    (void)state;
    memset(&desc, 0, sizeof desc);
    desc.order = COHSM_ORDER_HILBERT;
    desc.orientation = COHSM_ORIENTATION_POLAR;
    desc.domain.side[0] = desc.domain.side[1] = desc.map_side = 32;
    assert_int_equal(cohsm_build(&desc, &mesh, &maps, NULL), COHSM_OK);
    memset(instances, 0, sizeof instances);
    memset(&sight, 0, sizeof sight);
    instances[0].maps = instances[1].maps = maps;
    for (int k = 0; k < 4; k++) instances[1].transform[5 * k] = 1;
    instances[1].transform[12] = 0.8f;
    sight.instances = instances;
    sight.instance_count = 2;
    sight.query.light_kind = COHSM_LIGHT_POSITION;
    sight.query.lights = lights;
    sight.query.one_light = 1;                                  /* which is not read */
    for (uint32_t i = 0; i < LIGHTS; i++) {
        numbers[i] = 37 * i % LIGHTS;
        lights[3 * i] = 0.03f * (float)i - 1.5f;
        lights[3 * i + 1] = 0;
        lights[3 * i + 2] = 0.2f;
    }
    lights[1] = 1;
    lights[0] = lights[2] = 0.1f;                               /* light 0 lies on the first plate: refused, so seen */
    for (int filter = 0; filter < COHSM_FILTER_COUNT; filter++)
        for (int point = 0; point < 64; point++) {
            float p[3];
            cohsm_query query;
            p[0] = 0.05f * (float)point - 1.6f;
            p[1] = 2;
            p[2] = 0.3f;
            sight.query.filter = (cohsm_filter)filter;
            cohsm_see(&sight, p, n, numbers, LIGHTS, seen);
            query = sight.query;
            query.one_light = 0;
            for (int i = 0; i < LIGHTS; i++) {
                memcpy(at + 3 * i, p, sizeof p);
                memcpy(packed + 3 * i, lights + 3 * numbers[i], sizeof p);
                sum[filter] += (double)seen[i];
            }
            query.positions = at;
            query.lights = packed;
            query.count = LIGHTS;
            assert_int_equal(cohsm_visible_scene(instances, 2, &query, expected, NULL), COHSM_OK);
            for (int i = 0; i < LIGHTS; i++) refused += expected[i] < 0;
            for (int i = 0; i < LIGHTS; i++)
                if (filter != COHSM_FILTER_ROULETTE)
                    assert_true(fabsf(seen[i] - (expected[i] < 0 ? 1 : expected[i])) <= 0);
        }
    assert_true(refused > 64);
    assert_true(sum[COHSM_FILTER_PCF] > 1000 && sum[COHSM_FILTER_PCF] < 5400);
    assert_true(fabs(sum[COHSM_FILTER_ROULETTE] / sum[COHSM_FILTER_PCF] - 1) < 0.02);
    cohsm_free(maps);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plate_shadows_bounced_light_by_imperfect_maps),
        cmocka_unit_test(a_plate_shadows_bounced_light_by_coherent_maps_at_the_lights),
        cmocka_unit_test(a_plate_shadows_bounced_light_by_its_own_maps_of_directions),
        cmocka_unit_test(lights_that_are_not_there_are_seen_and_what_fails_is_dark),
        cmocka_unit_test(each_light_gets_what_a_query_gives),
    };
    return cmocka_run_group_tests(tests, make_plane, NULL);
}
