/* exchange_test - the headers with each other: one list of pixel lights through rsm, ism and csm; the lights
   of envshadow through csm; ambient occlusion of a shadow field. docs/together.md describes the same three. */
#include "csm.h"
#include "lightsampling.h"
#include "shadowfield.h"
#include "envlights.h"
#include "envshadow.h"
#include "rsm.h"
#include "ism.h"
#include "sky_lights.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

enum { RINGS = 24, SIDES = 48, VERTICES = 2 + (RINGS - 1) * SIDES, TRIANGLES = 2 * SIDES * (RINGS - 1) };

static const float center[3] = { 0.2f, 1.2f, -0.1f }, radius = 0.6f;        /* of the ball in every test here */

/* A ball of triangles, and behind it the floor y = 0 of 4 x 4. */
static float    positions[3 * (VERTICES + 4)];
static uint32_t indices[3 * (TRIANGLES + 2)];

static void put(uint32_t *n, uint32_t a, uint32_t b, uint32_t c)
{
    indices[(*n)++] = a;
    indices[(*n)++] = b;
    indices[(*n)++] = c;
}

static int make_scene(void **state)
{
    static const float floor_corners[12] = { -2, 0, -2, -2, 0, 2, 2, 0, 2, 2, 0, -2 };
    uint32_t i, j, n = 0, last = VERTICES - 1;
    (void)state;
    for (i = 0; i < VERTICES; i++) {
        uint32_t ring = i == 0 ? 0 : i == last ? RINGS : 1 + (i - 1) / SIDES;
        double a = 3.14159265358979 * ring / RINGS, b = 6.28318530717959 * ((i + SIDES - 1) % SIDES) / SIDES;
        positions[3 * i] = center[0] + radius * (float)(sin(a) * cos(b));
        positions[3 * i + 1] = center[1] + radius * (float)cos(a);
        positions[3 * i + 2] = center[2] + radius * (float)(sin(a) * sin(b));
    }
    for (j = 0; j < SIDES; j++) {
        uint32_t k = (j + 1) % SIDES;
        put(&n, 0, 1 + k, 1 + j);
        for (i = 0; i + 2 < RINGS; i++) {
            uint32_t a = 1 + i * SIDES, b = a + SIDES;
            put(&n, a + j, a + k, b + k);
            put(&n, a + j, b + k, b + j);
        }
        put(&n, last, 1 + (RINGS - 2) * SIDES + j, 1 + (RINGS - 2) * SIDES + k);
    }
    memcpy(positions + 3 * VERTICES, floor_corners, sizeof floor_corners);
    put(&n, VERTICES, VERTICES + 1, VERTICES + 2);
    put(&n, VERTICES, VERTICES + 2, VERTICES + 3);
    return n == 3 * (TRIANGLES + 2) ? 0 : -1;
}

static float dot3(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Does the ball, shrunk a little for its facets, lie between p and p + d? far: largest multiple of d. */
static int ball_hides(const float *p, const float *d, float far)
{
    float o[3] = { p[0] - center[0], p[1] - center[1], p[2] - center[2] }, r = 0.997f * radius;
    float a = dot3(d, d), b = dot3(o, d), root = b * b - a * (dot3(o, o) - r * r), t;
    if (!(root > 0)) return 0;
    t = (-b - sqrtf(root)) / a;
    return t > 0 && t < far;
}

/* ---- one list of pixel lights ---- */

enum { SIDE = 12, POINTS = SIDE * SIDE, MAP = 8, LIGHTS = MAP * MAP };

static float ceiling[3 * POINTS], down[3 * POINTS];

static void make_ceiling(void)
{
    for (int i = 0; i < POINTS; i++) {
        ceiling[3 * i] = 3.4f * ((float)(i % SIDE) / (SIDE - 1) - 0.5f);
        ceiling[3 * i + 1] = 2.5f;
        ceiling[3 * i + 2] = 3.4f * ((float)(i / SIDE) / (SIDE - 1) - 0.5f);
        down[3 * i + 1] = -1;
    }
}

/* A sun straight above: its 8 x 8 texels hold a 64th of the light each. with_ball: it catches some. */
static rsm_map *make_map(int with_ball)
{
    rsm_mesh meshes[2];
    rsm_desc desc;
    rsm_map *map = NULL;
    memset(meshes, 0, sizeof meshes);
    memset(&desc, 0, sizeof desc);
    for (int i = 0; i < 2; i++) {
        meshes[i].positions = positions;
        meshes[i].vertex_count = VERTICES + 4;
        meshes[i].indices = i ? indices : indices + 3 * TRIANGLES;
        meshes[i].index_count = i ? 3 * TRIANGLES : 6;
        for (int k = 0; k < 3; k++) meshes[i].albedo[k] = 0.8f - 0.2f * (float)k;
    }
    desc.light.direction[1] = 1;
    desc.light.value[0] = desc.light.value[1] = desc.light.value[2] = 10;
    desc.light.radius = 2;
    desc.light.near_depth = -4;
    desc.light.far_depth = 4;
    desc.side = MAP;
    assert_int_equal(rsm_map_create(&desc, &map), RSM_OK);
    assert_int_equal(rsm_rasterize(map, meshes, with_ball ? 2 : 1), RSM_OK);
    assert_int_equal(rsm_finish(map, NULL), RSM_OK);
    return map;
}

/* The list of rsm.h as a source of ism.h, where it lies. */
static ism_source source_of(const rsm_texel *lights, uint32_t width, uint32_t height)
{
    ism_source source;
    memset(&source, 0, sizeof source);
    source.width = width;
    source.height = height;
    source.positions = lights->position;
    source.normals = lights->normal;
    source.fluxes = lights->flux;
    source.areas = &lights->area;
    source.position_stride = source.normal_stride = source.flux_stride = source.area_stride = sizeof *lights;
    return source;
}

/* sum over lights of flux / pi cos cos / d^2, in double; exact: without those that the ball hides. */
static void add_up(const rsm_texel *lights, size_t count, int exact, float *out)
{
    for (int p = 0; p < POINTS; p++) {
        double sum[3] = { 0, 0, 0 };
        for (size_t i = 0; i < count; i++) {
            float d[3];
            double d2, form;
            for (int k = 0; k < 3; k++) d[k] = lights[i].position[k] - ceiling[3 * p + k];
            d2 = (double)dot3(d, d);
            form = (double)dot3(d, down + 3 * p) * -(double)dot3(d, lights[i].normal) / (d2 * d2 * 3.14159265358979);
            if (!(form > 0) || -dot3(d, lights[i].normal) <= 0 || (exact && ball_hides(ceiling + 3 * p, d, 0.999f)))
                continue;
            for (int k = 0; k < 3; k++) sum[k] += form * (double)lights[i].flux[k];
        }
        for (int k = 0; k < 3; k++) out[3 * p + k] = (float)sum[k];
    }
}

/* sqrt(mean((a - b)^2)) / mean(b) */
static double difference(const float *a, const float *b, size_t count)
{
    double squares = 0, sum = 0;
    for (size_t i = 0; i < count; i++) {
        squares += ((double)a[i] - (double)b[i]) * ((double)a[i] - (double)b[i]);
        sum += (double)b[i];
    }
    assert_true(sum > 0);
    return sqrt(squares / (double)count) / (sum / (double)count);
}

static rsm_points ceiling_points(void)
{
    rsm_points points;
    memset(&points, 0, sizeof points);
    points.count = POINTS;
    points.positions = ceiling;
    points.normals = down;
    return points;
}

static ism_frame make_frame(const ism_mesh *mesh, const ism_points *view)
{
    ism_frame frame;
    memset(&frame, 0, sizeof frame);
    frame.mesh = mesh;
    frame.points = view;
    return frame;
}

static ism_points ceiling_view(void)
{
    ism_points view;
    memset(&view, 0, sizeof view);
    view.positions = ceiling;
    view.normals = down;
    view.count = POINTS;
    return view;
}

/* ism chooses from the map's texels as they are, through the strides of ism_source. */
static void choose_from_texels(ism_maps *ism, ism_frame frame, const rsm_texel *texels, double flux)
{
    const ism_vpl *vpls;
    ism_source source;
    size_t count, i;
    source = source_of(texels, MAP, MAP);
    frame.sources = &source;
    frame.source_count = 1;
    assert_int_equal(ism_choose(ism, &frame), ISM_OK);
    vpls = ism_vpls(ism, &count);
    assert_int_equal(count, LIGHTS);
    for (i = 0; i < count; i++) {
        const rsm_texel *texel = &texels[vpls[i].texel];
        for (int k = 0; k < 3; k++) assert_true(fabsf(vpls[i].position[k] - texel->position[k]) < 1e-6f);
        assert_true(fabsf(vpls[i].area - texel->area) < 1e-5f && fabsf(texel->area - 0.25f) < 1e-5f);
        flux -= (double)vpls[i].flux[0];
    }
    assert_true(fabs(flux) < 1e-3);
    source.area_stride = 6;
    assert_int_equal(ism_choose(ism, &frame), ISM_ERR_ARGUMENT);
}

/* Nothing occludes: rsm's gather, ism without maps and the sum itself are one number. */
static void without_occluders_both_give_the_same_light(void **state)
{
    static float sum[3 * POINTS], gathered[3 * POINTS], shaded[3 * POINTS];
    rsm_texel lights[LIGHTS];
    ism_source source;
    rsm_map *map = make_map(0);
    const rsm_map *maps[1];
    rsm_gather_desc gather;
    rsm_points points = ceiling_points();
    ism_points view = ceiling_view();
    ism_frame frame = make_frame(NULL, &view);
    ism_shading shading = { 0 };
    ism_desc desc;
    ism_maps *ism;
    size_t count = 0, i;
    double flux = 0;
    (void)state;
    maps[0] = map;
    assert_int_equal(rsm_pixel_lights(maps, 1, 0, 0, lights, LIGHTS, &count), RSM_OK);
    assert_int_equal(count, LIGHTS);
    for (i = 0; i < count; i++) flux += (double)lights[i].flux[0];
    assert_true(fabs(flux - 10 * 16 * 0.8) < 1e-4);         /* E x area x albedo */
    add_up(lights, count, 0, sum);
    memset(&gather, 0, sizeof gather);
    assert_int_equal(rsm_gather_list(lights, count, &gather, &points, gathered, NULL), RSM_OK);
    assert_true(difference(gathered, sum, 3 * POINTS) < 1e-5);

    memset(&desc, 0, sizeof desc);
    desc.vpl_count = LIGHTS;
    desc.importance = ISM_IMPORTANCE_FLUX;
    desc.no_inter_texel = 1;
    shading.no_maps = 1;
    shading.near_mode = ISM_NEAR_NONE;
    assert_int_equal(ism_create(&desc, &ism), ISM_OK);
    source = source_of(lights, LIGHTS, 1);
    assert_int_equal(ism_set_sources(ism, &source, 1), ISM_OK);
    assert_int_equal(ism_shade(ism, &view, &shading, shaded, NULL), ISM_OK);
    assert_true(difference(shaded, sum, 3 * POINTS) < 1e-5);

    choose_from_texels(ism, frame, rsm_map_texels(map), flux);
    ism_free(ism);
    rsm_map_free(map);
}

/* One cube map at each light, a little above its surface. */
static cohsm_maps *maps_at(const rsm_texel *lights, size_t count)
{
    static float locations[4 * LIGHTS];
    cohsm_mesh mesh = { positions, VERTICES + 4, 0, indices, 3 * (TRIANGLES + 2), NULL, NULL, NULL };
    cohsm_desc desc;
    cohsm_maps *maps = NULL;
    memset(&desc, 0, sizeof desc);
    cohsm_light_locations(lights->position, sizeof *lights, lights->normal, sizeof *lights, count, 0.01f, locations);
    desc.domain.kind = COHSM_DOMAIN_LIST;
    desc.domain.locations = locations;
    desc.domain.location_count = count;
    desc.order = COHSM_ORDER_SCANLINE;
    desc.map_side = 48;
    assert_int_equal(cohsm_build(&desc, &mesh, &maps, NULL), COHSM_OK);
    return maps;
}

static double brightest(const float *light, size_t count)
{
    double most = 0;
    while (count--) most = fmax(most, (double)light[count]);
    return most;
}

/* A ball that catches part of the sun and hides part of its bounce: the imperfect maps of ism.h are near the truth, the
   maps of csm.h nearer still, from the same list; and rsm.h, which gathers with either, says what ism.h does. */
static void an_occluder_hides_the_same_light_from_all(void **state)
{
    static float open[3 * POINTS], exact[3 * POINTS], by_ism[3 * POINTS], by_csm[3 * POINTS], gathered[3 * POINTS];
    rsm_texel lights[LIGHTS];
    rsm_map *map = make_map(1);
    const rsm_map *maps[1];
    rsm_points points = ceiling_points();
    rsm_gather_desc gather;
    ism_mesh mesh = { positions, VERTICES + 4, 0, indices, 3 * (TRIANGLES + 2), NULL, NULL, NULL, NULL, NULL };
    ism_points view = ceiling_view();
    ism_frame frame = make_frame(&mesh, &view);
    ism_shading shading = { 0 };
    ism_source source;
    ism_desc desc;
    ism_maps *ism;
    ism_sight by_points = { NULL, 0 };
    cohsm_instance instance;
    cohsm_sight sight;
    size_t count = 0;
    (void)state;
    maps[0] = map;
    assert_int_equal(rsm_pixel_lights(maps, 1, 0, 0, lights, LIGHTS, &count), RSM_OK);
    add_up(lights, count, 0, open);
    add_up(lights, count, 1, exact);
    memset(&instance, 0, sizeof instance);
    memset(&sight, 0, sizeof sight);
    instance.maps = maps_at(lights, count);
    sight.instances = &instance;
    sight.instance_count = 1;
    sight.query.light_kind = COHSM_LIGHT_INDEX;
    memset(&desc, 0, sizeof desc);
    desc.vpl_count = LIGHTS;
    desc.surfel_count = 2048;
    assert_int_equal(ism_create(&desc, &ism), ISM_OK);
    source = source_of(lights, (uint32_t)count, 1);
    assert_int_equal(ism_set_sources(ism, &source, 1), ISM_OK);
    assert_int_equal(ism_build(ism, &frame), ISM_OK);
    shading.near_mode = ISM_NEAR_NONE;
    assert_int_equal(ism_shade(ism, &view, &shading, by_ism, NULL), ISM_OK);
    shading.visible_fn = cohsm_see;
    shading.visible_user = &sight;
    assert_int_equal(ism_shade(ism, &view, &shading, by_csm, NULL), ISM_OK);
    print_message("relative RMSE to exact visibility: none %.4f, ism %.4f, csm %.4f\n",
                  difference(open, exact, 3 * POINTS), difference(by_ism, exact, 3 * POINTS),
                  difference(by_csm, exact, 3 * POINTS));
    assert_true(difference(open, exact, 3 * POINTS) > 0.1);
    assert_true(difference(by_ism, exact, 3 * POINTS) < 0.08);
    assert_true(difference(by_csm, exact, 3 * POINTS) < 0.02);

    memset(&gather, 0, sizeof gather);
    gather.visible_fn = ism_see;
    gather.visible_user = &by_points;
    by_points.maps = ism;
    assert_int_equal(rsm_gather(maps, 1, &gather, &points, gathered, NULL), RSM_OK);
    for (int i = 0; i < 3 * POINTS; i++)
        assert_true(fabs((double)gathered[i] - (double)by_ism[i]) <= 1e-5 * brightest(open, 3 * POINTS));
    gather.visible_fn = cohsm_see;
    gather.visible_user = &sight;
    assert_int_equal(rsm_gather_list(lights, count, &gather, &points, gathered, NULL), RSM_OK);
    for (int i = 0; i < 3 * POINTS; i++)
        assert_true(fabs((double)gathered[i] - (double)by_csm[i]) <= 1e-5 * brightest(open, 3 * POINTS));
    cohsm_free((cohsm_maps *)(uintptr_t)instance.maps);
    ism_free(ism);
    rsm_map_free(map);
}

/* ---- a sky's lights ---- */

enum { GRID = 24, FLOOR_POINTS = GRID * GRID, K = 48 };

static float ground[3 * FLOOR_POINTS], up[3 * FLOOR_POINTS];

static void make_ground(void)
{
    for (int i = 0; i < FLOOR_POINTS; i++) {
        ground[3 * i] = 6 * (((float)(i % GRID) + 0.5f) / GRID - 0.5f);
        ground[3 * i + 2] = 6 * (((float)(i / GRID) + 0.5f) / GRID - 0.5f);
        up[3 * i + 1] = 1;
    }
}

static envlt_lights *make_sky(void)
{
    static float sky[3 * 64 * 32];
    envlt_map map = { ENVLT_PROJECTION_LATLONG, 64, 32, sky, 0 };
    envlt_desc desc;
    envlt_lights *lights = NULL;
    for (uint32_t i = 0; i < 64 * 32; i++) {
        float d[3], glow;
        envlt_texel_direction(ENVLT_PROJECTION_LATLONG, 64, 32, 0, (float)(i % 64) + 0.5f, (float)(i / 64) + 0.5f, d);
        glow = 0.6f * d[0] + 0.64f * d[1] - 0.48f * d[2];
        for (int k = 0; k < 3; k++) sky[3 * i + (uint32_t)k] = 0.4f + 0.1f * (float)k + (glow > 0.9f ? 20.0f : 0.0f);
    }
    memset(&desc, 0, sizeof desc);
    desc.light_count = K;
    desc.hemisphere = 1;
    assert_int_equal(envlt_create(&desc, &map, &lights, NULL), ENVLT_OK);
    return lights;
}

/* Maps of the k directions alone, asked by number: exact but for pixels. Or of 32 x 32, for a sky that turns: snapped
 * to them. */
static cohsm_maps *maps_of(const envlt_light *list, uint32_t count)
{
    cohsm_mesh ball = { positions, VERTICES, 0, indices, 3 * TRIANGLES, NULL, NULL, NULL };
    float locations[4 * K];
    cohsm_desc desc;
    cohsm_maps *maps = NULL;
    memset(&desc, 0, sizeof desc);
    for (uint32_t i = 0; list && i < count; i++) {
        memcpy(locations + 4 * i, list[i].direction, sizeof list[i].direction);
        locations[4 * i + 3] = 0;
    }
    if (list) {
        desc.domain.kind = COHSM_DOMAIN_LIST;
        desc.domain.locations = locations;
        desc.domain.location_count = count;
    }
    desc.domain.side[0] = desc.domain.side[1] = 32;
    desc.map_side = list ? 128 : 64;
    desc.order = list ? COHSM_ORDER_SCANLINE : COHSM_ORDER_HILBERT;
    desc.orientation = COHSM_ORIENTATION_POLAR;
    assert_int_equal(cohsm_build(&desc, &ball, &maps, NULL), COHSM_OK);
    return maps;
}

/* What lsamp_light_domain writes is copied into a cohsm_domain by number and field. */
static void domains_of_lights_have_the_numbers_of_csm(void **state)
{
    (void)state;
    assert_int_equal(LSAMP_DOMAIN_LATLONG, COHSM_DOMAIN_LATLONG);
    assert_int_equal(LSAMP_DOMAIN_LINE, COHSM_DOMAIN_LINE);
    assert_int_equal(LSAMP_DOMAIN_RECTANGLE, COHSM_DOMAIN_RECTANGLE);
    assert_int_equal(LSAMP_DOMAIN_DISC, COHSM_DOMAIN_DISC);
    assert_int_equal(LSAMP_DOMAIN_SPHERE, COHSM_DOMAIN_SPHERE);
    assert_int_equal(LSAMP_DOMAIN_TABLE, COHSM_DOMAIN_TABLE);
    assert_int_equal(LSAMP_DOMAIN_LIST, COHSM_DOMAIN_LIST);
    assert_int_equal(LSAMP_DOMAIN_COUNT, COHSM_DOMAIN_COUNT);
}


/* csm's maps answer for the k lights of envshadow; beside them rays against the ball, and envshadow's own maps. */
static void lights_of_a_sky_shadow_through_csm_as_by_rays(void **state)
{
    static float visible[FLOOR_POINTS], turning[FLOOR_POINTS], own[FLOOR_POINTS];
    envsh_mesh caster = { positions, VERTICES, 0, indices, 3 * TRIANGLES, NULL, NULL, NULL };
    cohsm_query query = { 0 };
    envsh_query own_query = { ENVSH_FILTER_PLAIN, 0, 0, 0, 0, 0, 0 };
    envsh_points receivers = { FLOOR_POINTS, ground, 0, up, 0, NULL, 0, 0 };
    envlt_lights *lights = make_sky();
    const envlt_light *list;
    envsh_maps *atlas;
    cohsm_maps *maps, *any;
    uint32_t count, wrong = 0, own_wrong = 0, dark = 0;
    double by_csm = 0, by_any = 0, by_rays = 0, of_all = 0;
    (void)state;
    list = envlt_get_lights(lights, &count);
    assert_int_equal(count, K);
    maps = maps_of(list, count);
    any = maps_of(NULL, 0);
    assert_int_equal(envsh_maps_create(NULL, count, &atlas), ENVSH_OK);
    assert_int_equal(envsh_maps_begin(atlas, AS_LIGHTS(list, count), envsh_bounds_of(&caster, 1, NULL)), ENVSH_OK);
    assert_int_equal(envsh_maps_draw(atlas, &caster, NULL), ENVSH_OK);
    assert_int_equal(envsh_maps_end(atlas), ENVSH_OK);
    query.positions = ground;
    query.count = FLOOR_POINTS;
    query.one_light = 1;
    for (uint32_t i = 0; i < count; i++) {
        query.light_kind = COHSM_LIGHT_INDEX;
        query.filter = COHSM_FILTER_NEAREST;
        query.lights = &i;
        assert_int_equal(cohsm_visible(maps, &query, visible, NULL), COHSM_OK);
        query.light_kind = COHSM_LIGHT_DIRECTION;
        query.filter = COHSM_FILTER_PCF;
        query.lights = list[i].direction;
        assert_int_equal(cohsm_visible(any, &query, turning, NULL), COHSM_OK);
        assert_int_equal(envsh_visible(atlas, i, &own_query, &receivers, own), ENVSH_OK);
        for (int p = 0; p < FLOOR_POINTS; p++) {
            int lit = !ball_hides(ground + 3 * p, list[i].direction, 1e9f);
            double light = (double)(list[i].irradiance[1] * list[i].direction[1]);
            wrong += (visible[p] >= 0.5f) != lit;
            own_wrong += (own[p] >= 0.5f) != lit;
            dark += !lit;
            by_csm += light * (double)visible[p];
            by_any += light * (double)turning[p];
            by_rays += light * lit;
            of_all += light;
        }
    }
    print_message("of %u pairs in shadow of %u, wrong: csm %u, envshadow %u\n", dark, count * FLOOR_POINTS, wrong,
                  own_wrong);
    print_message("light over that of rays: csm of these lights %.5f, of all directions %.5f, unshadowed %.5f\n",
                  by_csm / by_rays, by_any / by_rays, of_all / by_rays);
    assert_true(dark > count * FLOOR_POINTS / 50);
    assert_true(wrong < dark / 20 && own_wrong < dark / 20);
    assert_true(fabs(by_csm / by_rays - 1) < 0.002 && fabs(by_any / by_rays - 1) < 0.005 && of_all / by_rays > 1.02);
    envsh_maps_free(atlas);
    cohsm_free(any);
    cohsm_free(maps);
    envlt_free(lights);
}

/* ---- ambient occlusion ---- */

/* A ball over a plane: what it hides of the cosine-weighted sky is (r / d)^2 cos, of all directions its cap. The same
   numbers are factors of rsm's bounced light. */
static void ambient_occlusion_of_a_field_is_the_balls_cap(void **state)
{
    static float open[FLOOR_POINTS], share[FLOOR_POINTS], local[3 * FLOOR_POINTS];
    static float plain[3 * FLOOR_POINTS], dimmed[3 * FLOOR_POINTS];
    static const float sky[3] = { 1, 1, 1 };
    sfield_mesh ball = { positions, VERTICES, 0, indices, 3 * TRIANGLES, NULL, NULL, NULL };
    sfield_entity entity = upright;
    sfield_scene_desc scene_desc;
    sfield_points set;
    sfield_desc desc;
    sfield_field *field;
    sfield_scene *scene;
    rsm_texel light;
    rsm_gather_desc gather;
    rsm_points points;
    double worst = 0, worst_share = 0;
    float least = 1;
    (void)state;
    memset(&desc, 0, sizeof desc);
    desc.shell_count = 8;
    desc.position_side = 8;
    desc.cube_side = 8;
    desc.inner = 1;
    desc.outer = 8;
    assert_int_equal(sfield_build(&desc, &ball, &field, NULL), SFIELD_OK);
    memset(&scene_desc, 0, sizeof scene_desc);
    assert_int_equal(sfield_scene_create(&scene_desc, &scene), SFIELD_OK);
    entity.occlusion = field;
    assert_int_equal(sfield_scene_entities(scene, &entity, 1), SFIELD_OK);
    assert_int_equal(sfield_scene_environment(scene, sky, 1, 1, NULL), SFIELD_OK);
    memset(&set, 0, sizeof set);
    set.count = FLOOR_POINTS;
    set.positions = ground;
    set.normals = up;
    set.entity = 0;
    set.ambient = open;
    assert_int_equal(sfield_shade(scene, &set, 1, NULL), SFIELD_OK);
    memcpy(local, ground, sizeof local);
    assert_int_equal(sfield_ambient(field, FLOOR_POINTS, local, share), SFIELD_OK);
    for (int p = 0; p < FLOOR_POINTS; p++) {
        float d[3] = { center[0] - ground[3 * p], center[1], center[2] - ground[3 * p + 2] };
        double far = sqrt((double)dot3(d, d)), r = (double)radius / far;
        double hidden = r * r * (double)center[1] / far, cap = 0.5 * (1 - sqrt(1 - r * r));
        worst = fmax(worst, fabs((double)open[p] - (1 - hidden)));
        worst_share = fmax(worst_share, fabs((double)share[p] - (1 - cap)));
        if (open[p] < least) least = open[p];
    }
    print_message("least open %.4f; off the closed form at most %.4f, share of all directions %.4f\n", (double)least,
                  worst, worst_share);
    assert_true(least < 0.78f);                 /* 0.75 straight below */
    assert_true(worst < 0.01 && worst_share < 0.004);

    memset(&light, 0, sizeof light);
    light.position[1] = 3;
    light.normal[1] = -1;
    light.flux[0] = light.flux[1] = light.flux[2] = 100;
    memset(&gather, 0, sizeof gather);
    memset(&points, 0, sizeof points);
    points.count = FLOOR_POINTS;
    points.positions = ground;
    points.normals = up;
    assert_int_equal(rsm_gather_list(&light, 1, &gather, &points, plain, NULL), RSM_OK);
    points.open = open;
    assert_int_equal(rsm_gather_list(&light, 1, &gather, &points, dimmed, NULL), RSM_OK);
    for (int p = 0; p < 3 * FLOOR_POINTS; p++)
        assert_true(fabsf(dimmed[p] - plain[p] * open[p / 3]) <= 1e-6f * plain[p]);
    sfield_scene_free(scene);
    sfield_free(field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_occluders_both_give_the_same_light),
        cmocka_unit_test(an_occluder_hides_the_same_light_from_all),
        cmocka_unit_test(lights_of_a_sky_shadow_through_csm_as_by_rays),
        cmocka_unit_test(domains_of_lights_have_the_numbers_of_csm),
        cmocka_unit_test(ambient_occlusion_of_a_field_is_the_balls_cap),
    };
    make_ceiling();
    make_ground();
    return cmocka_run_group_tests(tests, make_scene, NULL);
}
