/* maps_rows_test - rows T23 and T24, the sealed box, and each filter against brute force: shadow maps on the CPU. */

#include "envlights.h"
#include "envshadow.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>
#include "conformance.h"
#include "util.h"

static soup geometry;                   /* too large for the stack */

static uint32_t lights_of(sky_fn fn, uint32_t k, int hemisphere, envlt_light *out)
{
    sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 128, 64);
    envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, k);
    envlt_lights *l;
    uint32_t count;
    d.hemisphere = hemisphere;
    sky_fill(&s, fn);
    assert_int_equal(envlt_create(&d, &s.map, &l, NULL), ENVLT_OK);
    memcpy(out, envlt_get_lights(l, &count), k * sizeof *out);
    assert_int_equal(count, k);
    envlt_free(l);
    sky_free(&s);
    return count;
}

static envsh_maps *maps_of(uint32_t size, int rgba, uint32_t capacity)
{
    envsh_maps_desc d;
    envsh_maps *m;
    memset(&d, 0, sizeof d);
    d.map_side = size;
    d.rgba = rgba;
    assert_int_equal(envsh_maps_create(&d, capacity, &m), ENVSH_OK);
    return m;
}

static void draw(envsh_maps *m, const envlt_light *list, uint32_t count)
{
    envsh_mesh mesh = soup_mesh(&geometry);
    assert_int_equal(envsh_maps_begin(m, AS_LIGHTS(list, count), envsh_bounds_of(&mesh, 1, NULL)), ENVSH_OK);
    assert_int_equal(envsh_maps_draw(m, &mesh, NULL), ENVSH_OK);
    assert_int_equal(envsh_maps_end(m), ENVSH_OK);
}

static double shade_one(const envsh_maps *m, double x, double y, double z, const float *n, envsh_filter filter)
{
    envsh_query q = { 0 };
    envsh_points r = { 0 };
    float p[3], e[3];
    p[0] = (float)x;
    p[1] = (float)y;
    p[2] = (float)z;
    r.positions = p;
    r.normals = n;
    r.count = 1;
    q.filter = filter;
    if (filter == ENVSH_FILTER_SMOOTH || filter == ENVSH_FILTER_PCF) q.radius = 1.5f;
    assert_int_equal(envsh_shade(m, &q, &r, e), ENVSH_OK);
    return (double)e[1];
}

static const float up[3] = { 0, 1, 0 };

/* ---- T23 ---- */

static void uniform_sky_lights_the_ground(void **state)
{
    static envlt_light list[256];
    (void)state;
    /* A light of radius a stands for cosines that are smaller by a^2 / 4 on average: 0.8 % at 64 in a hemisphere. */
    for (int hemisphere = 0; hemisphere < 2; hemisphere++)
        for (uint32_t k = hemisphere ? 64 : 128; k <= 256; k *= 2) {
            uint32_t n = lights_of(even, k, hemisphere, list);
            envsh_maps *m = maps_of(64, 0, n);
            char what[80];
            geometry.vertices = 0;
            draw(m, list, n);
            snprintf(what, sizeof what, "irradiance under a uniform sky, %u lights%s", (unsigned)k,
                     hemisphere ? " of a hemisphere" : "");
            CONFORM("T23", what, PI, shade_one(m, 0, 0, 0, up, ENVSH_FILTER_PLAIN), 0.01 * PI);
            envsh_maps_free(m);
        }
}

static void a_wall_hides_half_of_the_sky_and_a_roof_all(void **state)
{
    static envlt_light list[400];
    static const double corner[3] = { -0.5, 0, -60 }, high[3] = { 0, 60, 0 }, wide[3] = { 0, 0, 120 };
    static const double above[3] = { -60, 1, -60 }, right[3] = { 120, 0, 0 };
    uint32_t n = lights_of(even, 400, 1, list);
    envsh_maps *m = maps_of(512, 0, n);
    double sum = 0;
    (void)state;
    geometry.vertices = 0;
    soup_quad(&geometry, corner, high, wide);
    draw(m, list, n);
    /* 60 half-units to each side leave 1e-4 of the half sky; single lights cross the edge: the mean over a strip */
    for (int i = 0; i < 64; i++)
        sum += shade_one(m, 0.2 + 0.01 * i, 0, 0.37 * i - 12, up, ENVSH_FILTER_PENUMBRA) / 64;
    CONFORM("T23", "irradiance at the foot of an infinite wall", PI / 2, sum, 0.01 * PI);
    geometry.vertices = 0;
    soup_quad(&geometry, above, right, wide);
    draw(m, list, n);
    sum = 0;
    for (int i = 0; i < 64; i++)
        sum += shade_one(m, 0.2 + 0.01 * i, 0, 0.37 * i - 12, up, ENVSH_FILTER_PENUMBRA) / 64;
    CONFORM_MAX("T23", "irradiance under an infinite roof", 0, sum);
    envsh_maps_free(m);
}

/* ---- T24 ---- */

/* Every second tile all near or all far; rewriting the others must change nothing here, under any filter. */
static void tiles_do_not_bleed(void **state)
{
    enum { K = 24, POINTS = 200 };
    static envlt_light list[K];
    static float near_map[64 * 64], far_map[64 * 64], points[3 * POINTS], normals[3 * POINTS], a[POINTS], b[POINTS];
    envsh_bounds box = { { -1, -1, -1 }, { 1, 1, 1 } };
    uint64_t seed = 3;
    uint32_t n = lights_of(even, K, 0, list);
    double changed = 0;
    int shadowed = 0;
    (void)state;
    for (size_t i = 0; i < 64 * 64; i++) {
        near_map[i] = 0.01f;
        far_map[i] = 1;
    }
    for (size_t i = 0; i < 3 * POINTS; i++) points[i] = (float)(2.6 * rnd(&seed) - 1.3);
    for (int rgba = 0; rgba < 2; rgba++)
        for (int filter = ENVSH_FILTER_PLAIN; filter < ENVSH_FILTER_COUNT; filter++) {
            envsh_maps *m = maps_of(64, rgba, n);
            envsh_query q = { 0 };
            envsh_points r = { 0 };
            r.positions = points;
            r.normals = normals;
            r.count = POINTS;
            q.filter = (envsh_filter)filter;
            q.radius = filter == ENVSH_FILTER_SMOOTH ? 8 : 30;      /* far wider than the guard */
            assert_int_equal(envsh_maps_begin(m, AS_LIGHTS(list, n), box), ENVSH_OK);
            for (uint32_t t = 0; t < n; t++)
                assert_int_equal(envsh_maps_set(m, t, t & 1 ? near_map : far_map, 0), ENVSH_OK);
            for (uint32_t t = 0; t < n; t++) {
                for (size_t i = 0; i < POINTS; i++) memcpy(normals + 3 * i, list[t].direction, 3 * sizeof(float));
                assert_int_equal(envsh_maps_end(m), ENVSH_OK);
                assert_int_equal(envsh_visible(m, t, &q, &r, a), ENVSH_OK);
                for (uint32_t o = 0; o < n; o++)
                    if (o != t) assert_int_equal(envsh_maps_set(m, o, o & 1 ? far_map : near_map, 0), ENVSH_OK);
                assert_int_equal(envsh_maps_end(m), ENVSH_OK);
                assert_int_equal(envsh_visible(m, t, &q, &r, b), ENVSH_OK);
                for (uint32_t o = 0; o < n; o++)
                    if (o != t) assert_int_equal(envsh_maps_set(m, o, o & 1 ? near_map : far_map, 0), ENVSH_OK);
                for (size_t i = 0; i < POINTS; i++) {
                    changed += fabs((double)a[i] - (double)b[i]);
                    shadowed += a[i] < 0.5f;
                    if (!(t & 1)) assert_true(a[i] > 0.999f);
                }
            }
            envsh_maps_free(m);
        }
    assert_true(shadowed > 1000);
    CONFORM_MAX("T24", "answers in a tile that change when its neighbours are rewritten", 0, changed);
}

/* ---- sealed box ---- */

static void sealed_box_is_dark(void **state)
{
    static envlt_light list[128];
    /* walls of six texels; sixteen for penumbrae, whose taps reach up to twelve */
    static const double outer[2][2][3] = { { { -1.1, -1.1, -1.1 }, { 1.1, 1.1, 1.1 } },
                                           { { -1.3, -1.3, -1.3 }, { 1.3, 1.3, 1.3 } } };
    static const double inner[2][3] = { { -1, -1, -1 }, { 1, 1, 1 } };
    uint32_t n = lights_of(sunny, 128, 0, list);
    (void)state;
    for (int filter = ENVSH_FILTER_PLAIN; filter < ENVSH_FILTER_COUNT; filter++) {
        static const char *const names[] = {
            "sealed box, mean light inside, plain", "sealed box, mean light inside, smooth",
            "sealed box, mean light inside, pcf", "sealed box, mean light inside, penumbra"
        };
        envsh_maps *m = maps_of(256, (filter - 1) & 1, n);
        double sum = 0;
        geometry.vertices = 0;
        soup_box(&geometry, outer[filter == ENVSH_FILTER_PENUMBRA][0], outer[filter == ENVSH_FILTER_PENUMBRA][1]);
        soup_box(&geometry, inner[0], inner[1]);
        draw(m, list, n);
        for (int axis = 0; axis < 3; axis++)
            for (int side = -1; side <= 1; side += 2) {
                float normal[3] = { 0, 0, 0 };
                normal[axis] = (float)-side;
                for (int i = 0; i < 100; i++) {         /* up to 0.002 from the edges */
                    double p[3];
                    p[axis] = side;
                    p[(axis + 1) % 3] = -0.998 + 1.996 * (i % 10) / 9.0;
                    p[(axis + 2) % 3] = -0.998 + 1.996 * (i / 10) / 9.0;
                    sum += shade_one(m, p[0], p[1], p[2], normal, (envsh_filter)filter);
                }
            }
        CONFORM_MAX("image", names[filter - ENVSH_FILTER_PLAIN], 0, sum / 600);
        envsh_maps_free(m);
    }
}

/* ---- the raster against rays ---- */

static double ray_depth(const soup *s, const envsh_view *v, double x, double y)
{
    double best = 1;
    for (size_t t = 0; t < s->vertices / 3; t++) {
        double c[3][3], area = 0, w[3];
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 3; k++) {
                const float *p = s->p + 9 * t + 3 * i, *row = v->lookup + 4 * k;
                c[i][k] = (double)row[3] + (double)row[0] * (double)p[0] + (double)row[1] * (double)p[1] +
                          (double)row[2] * (double)p[2];
            }
        for (int i = 0; i < 3; i++) {
            const double *a = c[(i + 1) % 3], *b = c[(i + 2) % 3];
            w[i] = (a[0] - x) * (b[1] - y) - (b[0] - x) * (a[1] - y);
            area += w[i];
        }
        if (!(fabs(area) > 1e-9)) continue;
        if (w[0] / area < 0 || w[1] / area < 0 || w[2] / area < 0) continue;
        best = fmin(best, (w[0] * c[0][2] + w[1] * c[1][2] + w[2] * c[2][2]) / area);
    }
    return best;
}

static void random_triangles(int count)
{
    uint64_t seed = 21;
    geometry.vertices = 0;
    for (int i = 0; i < count; i++) {
        double at[3];
        for (int c = 0; c < 3; c++) at[c] = 2 * rnd(&seed) - 1;
        for (int k = 0; k < 3; k++, geometry.vertices++)
            for (int c = 0; c < 3; c++)
                geometry.p[3 * geometry.vertices + (size_t)c] = (float)(at[c] + 0.5 * (2 * rnd(&seed) - 1));
    }
}

static void raster_equals_rays(void **state)
{
    static envlt_light list[6];
    uint32_t n = lights_of(even, 6, 0, list);
    envsh_maps *m = maps_of(64, 1, n);
    envsh_info atlas;
    const envsh_view *views;
    uint32_t count;
    size_t wrong = 0, covered = 0, edge = 0;
    double worst = 0;
    (void)state;
    random_triangles(40);
    draw(m, list, n);
    envsh_get_info(m, &atlas);
    views = envsh_views(m, &count);
    assert_int_equal(count, n);
    assert_int_equal(atlas.channel_count, 4);
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t y = 0; y < 64; y++)
            for (uint32_t x = 0; x < 64; x++) {
                size_t at = (size_t)(views[i].page * atlas.height + views[i].y + y) * atlas.width;
                double z = (double)atlas.depth[4 * (at + views[i].x + x) + views[i].channel], lo = 2, hi = -1;
                covered += z < 1;
                for (int k = 0; k < 9; k++) {           /* corners move by up to 1/512 texel: rays around */
                    double dx = 0.01 * (k % 3 - 1), dy = 0.01 * (k / 3 - 1);
                    double ray = ray_depth(&geometry, &views[i], x + 0.5 + dx, y + 0.5 + dy);
                    lo = fmin(lo, ray);
                    hi = fmax(hi, ray);
                    if (k == 4) worst = fmax(worst, fabs(ray - z) < 0.05 ? fabs(ray - z) : 0);
                }
                edge += hi - lo > 0.02;
                wrong += z < lo - 2e-3 || z > hi + 2e-3;
            }
    assert_true(covered > 3000 && edge < 1500);
    CONFORM_MAX("image", "texels of the depth raster that no ray nearby explains", 0, (double)wrong);
    envsh_maps_free(m);
}

/* A ground of two triangles far beyond the bounds: in every tile the plane that it is, and no shadow on itself. */
static void a_ground_without_end_is_flat(void **state)
{
    static const double halves[] = { 40, 3e3, 2e5, 1e7, 1e12 };
    static envlt_light list[6];
    uint32_t n = lights_of(even, 6, 1, list);
    envsh_bounds box = { { -5, 0, -5 }, { 5, 5, 5 } };
    double worst = 0, dark = 0;
    int compared = 0;
    (void)state;
    for (size_t h = 0; h < sizeof halves / sizeof halves[0]; h++) {
        const double corner[3] = { -halves[h], 0, -1.1 * halves[h] };
        const double wide[3] = { 2.3 * halves[h], 0, 0 }, along[3] = { 0, 0, 2 * halves[h] };
        envsh_maps *m = maps_of(128, 0, n);
        envsh_mesh mesh;
        envsh_info atlas;
        const envsh_view *views;
        geometry.vertices = 0;
        soup_quad(&geometry, corner, wide, along);
        mesh = soup_mesh(&geometry);
        assert_int_equal(envsh_maps_begin(m, AS_LIGHTS(list, n), box), ENVSH_OK);
        assert_int_equal(envsh_maps_draw(m, &mesh, NULL), ENVSH_OK);
        assert_int_equal(envsh_maps_end(m), ENVSH_OK);
        envsh_get_info(m, &atlas);
        views = envsh_views(m, NULL);
        for (uint32_t i = 0; i < n; i++) {
            const float *l = views[i].lookup;
            /* x and z of the ground from texels: two equations */
            double det = (double)l[0] * (double)l[6] - (double)l[2] * (double)l[4];
            for (uint32_t y = atlas.guard; y < 128 - atlas.guard; y++)
                for (uint32_t x = atlas.guard; x < 128 - atlas.guard; x++) {
                    double u = x + 0.5 - (double)l[3], v = y + 0.5 - (double)l[7];
                    double px = (u * (double)l[6] - v * (double)l[2]) / det, z;
                    double pz = (v * (double)l[0] - u * (double)l[4]) / det;
                    if (fabs(px) > 20 || fabs(pz) > 20) continue;       /* the smallest ground ends there */
                    z = (double)l[8] * px + (double)l[10] * pz + (double)l[11];
                    z = fmin(1, fmax(0, z));
                    compared += z > 0 && z < 1;
                    z -= (double)atlas.depth[(size_t)(views[i].y + y) * atlas.width + views[i].x + x];
                    worst = fmax(worst, fabs(z));
                }
        }
        for (int i = 0; i < 300; i++)
            dark = fmax(dark, 1 - shade_one(m, 0.9 * (i % 10) - 4, 0, 0.9 * (i / 10 % 10) - 4, up,
                                            (envsh_filter)(ENVSH_FILTER_PLAIN + i / 100)) /
                                  shade_one(m, 1e6, 1, 0, up, ENVSH_FILTER_PLAIN));
        envsh_maps_free(m);
    }
    assert_true(compared > 100000);
    /* 512ths of a texel times the slope, and floats of depths up to 500 ranges away */
    CONFORM_MAX("image", "ground of up to 1e12 across in maps of 10: depth off the plane, in ranges", 1e-4, worst);
    CONFORM_MAX("image", "ground of up to 1e12 across in maps of 10: shadow on itself, share of its light", 0, dark);
}

/* ---- filters against brute force ---- */

/* envsh_visibility_twin takes no shortcut: it must agree with the batch to the bit, for every filter and packing. */
static void shortcuts_change_nothing(void **state)
{
    enum { POINTS = 400 };
    static envlt_light list[8];
    static float points[3 * POINTS], normals[3 * POINTS], visible[POINTS];
    uint32_t n = lights_of(sunny, 8, 0, list);
    uint64_t seed = 77;
    double differ = 0;
    int between = 0;
    (void)state;
    random_triangles(12);
    for (size_t i = 0; i < POINTS; i++) {
        double d[3];
        rnd_direction(&seed, d);
        for (size_t c = 0; c < 3; c++) {
            points[3 * i + c] = (float)(3 * rnd(&seed) - 1.5);
            normals[3 * i + c] = (float)d[c];
        }
    }
    for (int filter = ENVSH_FILTER_PLAIN; filter < ENVSH_FILTER_COUNT; filter++) {
        envsh_maps *m = maps_of(96, (filter - 1) & 1, n);
        envsh_query q = { 0 };
        envsh_points r = { 0 };
        envsh_info atlas;
        const envsh_view *views;
        draw(m, list, n);
        envsh_get_info(m, &atlas);
        views = envsh_views(m, NULL);
        r.positions = points;
        r.normals = normals;
        r.count = POINTS;
        q.filter = (envsh_filter)filter;
        q.radius = filter == ENVSH_FILTER_PENUMBRA ? 20 : 2.5f;
        for (uint32_t t = 0; t < n; t++) {
            const envsh_view *v = &views[t];
            const float *corner = atlas.depth + ((size_t)(v->page * atlas.height + v->y) * atlas.width + v->x) *
                                  atlas.channel_count + v->channel;
            const envsh_tile tile = { v, corner, (size_t)4 * atlas.width * atlas.channel_count,
                                      (size_t)4 * atlas.channel_count, 96 };
            assert_int_equal(envsh_visible(m, t, &q, &r, visible), ENVSH_OK);
            for (uint32_t i = 0; i < POINTS; i++) {
                float twin = envsh_visibility_twin(&tile, &q, points + 3 * i, normals + 3 * i, i);
                differ += fabs((double)twin - (double)visible[i]);
                between += visible[i] > 0.01f && visible[i] < 0.99f;
            }
        }
        envsh_maps_free(m);
    }
    assert_true(between > 100);
    CONFORM_MAX("image", "visibility by cells and without them, sum of differences", 0, differ);
}

/* A half plane one above the ground, left of x = 0, under a disc of light of that radius (of directions). */
static void half_plane(envsh_maps *m, float radius)
{
    static const double corner[3] = { -4, 1, -4 }, u[3] = { 4, 0, 0 }, v[3] = { 0, 0, 8 };
    envlt_light light;
    memset(&light, 0, sizeof light);
    light.direction[1] = 1;
    light.irradiance[0] = light.irradiance[1] = light.irradiance[2] = 1;
    light.axis_u[0] = light.axis_v[2] = radius;
    geometry.vertices = 0;
    soup_quad(&geometry, corner, u, v);
    draw(m, &light, 1);
}

/* Its penumbra is as wide as the disc seen from its edge, whether the disc is that large or extent_scale makes it. */
static void penumbra_has_its_width(void **state)
{
    static const float scales[3] = { 1, 0.5f, 2 };
    envsh_maps *m = maps_of(512, 0, 1);
    double worst = 0, sum = 0;
    (void)state;
    for (int s = 0; s < 3; s++) {
        double last = -1;
        half_plane(m, 0.3f / scales[s]);
        for (int i = -20; i <= 20; i++) {
            double x = 0.02 * i, t = fmin(1, fmax(-1, x / 0.3)), mean = 0;
            double exact = 0.5 + (t * sqrt(1 - t * t) + asin(t)) / PI;  /* share of the disc that the edge leaves */
            for (int k = 0; k < 16; k++) {                              /* other rotations of the taps */
                envsh_query q = { 0 };
                envsh_points r = { 0 };
                float p[3], e[3];
                p[0] = (float)x;
                p[1] = 0;
                p[2] = 0.1f * (float)k;
                r.positions = p;
                r.normals = up;
                r.count = 1;
                q.tap_count = 64;
                q.radius = 64;
                q.seed = (uint32_t)k;
                q.extent_scale = scales[s];
                assert_int_equal(envsh_shade(m, &q, &r, e), ENVSH_OK);
                mean += (double)e[0] / 16;
            }
            worst = fmax(worst, fabs(mean - exact));
            sum += fabs(mean - exact) / (3 * 41);
            assert_true(mean > last - 0.03);
            last = mean;
        }
    }
    /* texels of 0.016 are a twentieth of the radius */
    CONFORM_MAX("image", "penumbra of a half plane, largest error of the share of light", 0.05, worst);
    CONFORM_MAX("image", "penumbra of a half plane, mean error of the share of light", 0.02, sum);
    envsh_maps_free(m);
}

enum { PLACES = 60 };

/* How many of the points from `begin` on have another visibility than `whole` says. */
static int unlike(const envsh_maps *m, const envsh_query *q, envsh_points r, size_t begin, const float *whole)
{
    float part[PLACES];
    int differ = 0;
    r.positions += 3 * begin;
    r.normals += 3 * begin;
    r.count -= begin;
    assert_int_equal(envsh_visible(m, 0, q, &r, part), ENVSH_OK);
    for (size_t i = 0; i < r.count; i++) differ += memcmp(&part[i], &whole[begin + i], sizeof *part) != 0;
    return differ;
}

/* Point i turns its taps by (seed, first + i): parts of an array have the answers of the whole. */
static void points_draw_by_seed_and_place(void **state)
{
    float points[3 * PLACES], normals[3 * PLACES], whole[PLACES];
    envsh_maps *m = maps_of(256, 0, 1);
    (void)state;
    half_plane(m, 0.3f);
    for (int i = 0; i < PLACES; i++) {          /* across the penumbra */
        points[3 * i] = 0.003f * (float)i - 0.09f;
        points[3 * i + 1] = 0;
        points[3 * i + 2] = 0.05f * (float)i - 1.5f;
        memcpy(normals + 3 * i, up, sizeof up);
    }
    for (int filter = ENVSH_FILTER_PCF; filter <= ENVSH_FILTER_PENUMBRA; filter++) {
        envsh_query q = { 0 };
        envsh_points r = { 0 };
        r.positions = points;
        r.normals = normals;
        r.count = PLACES;
        q.filter = (envsh_filter)filter;
        q.radius = 20;
        assert_int_equal(envsh_visible(m, 0, &q, &r, whole), ENVSH_OK);
        r.first = 23;
        assert_int_equal(unlike(m, &q, r, 23, whole), 0);
        assert_true(unlike(m, &q, r, 22, whole) > 5);
        q.seed = 9;
        assert_true(unlike(m, &q, r, 23, whole) > 5);
    }
    envsh_maps_free(m);
}

/* ---- algorithms 1 and 2, snapping, the cost model ---- */

static envsh_result draw_soup(void *user, envsh_maps *maps)
{
    envsh_mesh mesh = soup_mesh(&geometry);
    (void)user;
    return envsh_maps_draw(maps, &mesh, NULL);
}

static void clusters_sum_to_the_same(void **state)
{
    enum { K = 37, POINTS = 300 };
    static envlt_light list[K];
    static float points[3 * POINTS], normals[3 * POINTS], one[3 * POINTS], two[3 * POINTS];
    static const uint32_t clusters[] = { 1, 4, 8, 36, 64 };
    uint32_t n = lights_of(sunny, K, 0, list);
    uint64_t seed = 5;
    envsh_query q = { 0 };
    envsh_points r = { 0 };
    envsh_bounds box;
    envsh_mesh mesh;
    envsh_maps *m;
    (void)state;
    random_triangles(30);
    mesh = soup_mesh(&geometry);
    box = envsh_bounds_of(&mesh, 1, NULL);
    for (size_t i = 0; i < POINTS; i++) {
        double d[3];
        rnd_direction(&seed, d);
        for (size_t c = 0; c < 3; c++) {
            points[3 * i + c] = (float)(2 * rnd(&seed) - 1);
            normals[3 * i + c] = (float)d[c];
        }
    }
    r.positions = points;
    r.normals = normals;
    r.count = POINTS;
    m = maps_of(64, 0, K);
    assert_int_equal(envsh_illuminate(m, AS_LIGHTS(list, n), box, draw_soup, NULL, &q, &r, one), ENVSH_OK);
    envsh_maps_free(m);
    for (size_t i = 0; i < sizeof clusters / sizeof clusters[0]; i++) {
        m = maps_of(64, 1, clusters[i]);
        assert_int_equal(envsh_illuminate(m, AS_LIGHTS(list, n), box, draw_soup, NULL, &q, &r, two), ENVSH_OK);
        assert_memory_equal(one, two, sizeof one);
        envsh_maps_free(m);
    }
}

/* Bounds that move a little move texel coordinates of a fixed point by whole texels. */
static void texels_are_snapped(void **state)
{
    static envlt_light list[12];
    uint32_t n = lights_of(even, 12, 0, list);
    envsh_maps *m = maps_of(128, 0, n);
    envsh_bounds box = { { -1.03f, -1.03f, -1.03f }, { 1.03f, 1.03f, 1.03f } };
    uint64_t seed = 9;
    double worst = 0;
    int moved = 0;
    (void)state;
    for (int step = 0; step < 40; step++) {
        static float first[12][2][4];
        for (int c = 0; step && c < 3; c++) {
            float shift = (float)(0.05 * (2 * rnd(&seed) - 1));
            box.low[c] = -1.03f + shift;
            box.high[c] = 1.03f + shift;
        }
        assert_int_equal(envsh_maps_begin(m, AS_LIGHTS(list, n), box), ENVSH_OK);
        for (uint32_t i = 0; i < n; i++) {
            const envsh_view *v = envsh_views(m, NULL) + i;
            if (step == 0) memcpy(first[i], v->lookup, sizeof first[i]);
            for (int r = 0; r < 2; r++) {
                double shift = (double)v->lookup[4 * r + 3] - (double)first[i][r][3];
                for (int c = 0; c < 3; c++) assert_true(fabs((double)(v->lookup[4 * r + c] - first[i][r][c])) <= 0);
                worst = fmax(worst, fabs(shift - floor(shift + 0.5)));
                moved += fabs(shift) > 0.5;
            }
            for (int corner = 0; corner < 8; corner++)      /* and all of the box is inside the guard */
                for (int r = 0; r < 3; r++) {
                    const float *row = v->lookup + 4 * r;
                    double x = (double)(row[3] + row[0] * (corner & 1 ? box.high[0] : box.low[0]) +
                                        row[1] * (corner & 2 ? box.high[1] : box.low[1]) +
                                        row[2] * (corner & 4 ? box.high[2] : box.low[2]));
                    if (r < 2) assert_true(x > 4 - 1e-3 && x < 124 + 1e-3);
                    else assert_true(x > 0 && x < 1);
                }
        }
    }
    assert_true(moved > 100);
    CONFORM_MAX("image", "moved bounds move shadow texels by parts of a texel", 0, worst);
    envsh_maps_free(m);
}

static void cost_model_finds_the_best(void **state)
{
    static const uint32_t sizes[] = { 1, 4, 8, 32, 192 };
    double ms[5];
    envsh_cost cost, found;
    (void)state;
    cost.pass = 0.4;
    cost.slot = 0.03;
    for (int i = 0; i < 5; i++) {
        double passes = (191 + sizes[i]) / sizes[i];
        ms[i] = passes * (cost.pass + sizes[i] * cost.slot);
    }
    assert_int_equal(envsh_cost_fit(192, sizes, ms, 5, &found), 1);
    CLOSE(found.pass, cost.pass, 1e-9);
    CLOSE(found.slot, cost.slot, 1e-9);
    assert_int_equal(envsh_cost_cluster(&found, 192, 500), 192);
    assert_int_equal(envsh_cost_cluster(&found, 192, 100), 96);     /* two full passes, not 100 and 92 */
    assert_int_equal(envsh_cost_cluster(&found, 1, 8), 1);
    assert_int_equal(envsh_cost_fit(192, sizes, ms, 1, &found), 0); /* one measurement says nothing of two costs */
    assert_int_equal(envsh_cost_fit(192, sizes, ms, 0, &found), 0);
}

/* ---- conventions of clip space ---- */

/* What a GPU makes of a point by view.clip: column, row in memory and depth, 0..1. They must be those of the lookup,
   which is one for all APIs, and nothing of the bounds may be clipped. */
static void clip_spaces_meet_the_lookup(void **state)
{
    enum { K = 12, SIZE = 64 };
    static envlt_light list[K];
    const envsh_bounds box = { { -1, 0, -2 }, { 1.5f, 1, 2 } };
    double worst = 0;
    (void)state;
    lights_of(even, K, 0, list);
    for (int way = 0; way < 8; way++) {
        const envsh_clip_depth depths[] = {
            ENVSH_CLIP_DEPTH_DEFAULT, ENVSH_CLIP_DEPTH_ZERO_TO_ONE, ENVSH_CLIP_DEPTH_REVERSED,
            ENVSH_CLIP_DEPTH_MINUS_ONE_TO_ONE
        };
        envsh_maps_desc d;
        envsh_maps *m;
        const envsh_view *views;
        uint32_t count;
        uint64_t seed = 5;
        memset(&d, 0, sizeof d);
        d.map_side = SIZE;
        d.clip_depth = depths[way & 3];
        d.rows = way & 4 ? ENVSH_ROWS_TOP_FIRST : ENVSH_ROWS_DEFAULT;
        assert_int_equal(envsh_maps_create(&d, K, &m), ENVSH_OK);
        assert_int_equal(envsh_maps_begin(m, AS_LIGHTS(list, K), box), ENVSH_OK);
        assert_int_equal(envsh_maps_end(m), ENVSH_OK);
        views = envsh_views(m, &count);
        for (uint32_t i = 0; i < 100 * count; i++) {
            const envsh_view *v = &views[i % count];
            double p[4] = { 0, 0, 0, 1 }, clip[4], at[3];
            for (int c = 0; c < 3; c++)
                p[c] = (double)box.low[c] + ((double)box.high[c] - (double)box.low[c]) * rnd(&seed);
            for (int r = 0; r < 4; r++) {
                clip[r] = 0;
                for (int c = 0; c < 4; c++) clip[r] += (double)v->world_to_clip[4 * c + r] * p[c];
            }
            CLOSE(clip[3], 1, 1e-6);
            at[0] = (0.5 * clip[0] + 0.5) * SIZE;
            at[1] = (0.5 * (way & 4 ? -clip[1] : clip[1]) + 0.5) * SIZE;
            at[2] = (way & 3) == 1 ? clip[2] : (way & 3) == 2 ? 1 - clip[2] : 0.5 * clip[2] + 0.5;
            assert_true(at[0] > 0 && at[0] < SIZE && at[1] > 0 && at[1] < SIZE && at[2] >= 0 && at[2] <= 1);
            for (int r = 0; r < 3; r++) {
                double found = (double)v->lookup[4 * r + 3];
                for (int c = 0; c < 3; c++) found += (double)v->lookup[4 * r + c] * p[c];
                worst = fmax(worst, fabs(found - at[r]) / (r < 2 ? SIZE : 1));
            }
        }
        envsh_maps_free(m);
    }
    assert_true(worst < 1e-5);              /* of a tile: floats of sums of four */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(uniform_sky_lights_the_ground),
        cmocka_unit_test(a_wall_hides_half_of_the_sky_and_a_roof_all),
        cmocka_unit_test(tiles_do_not_bleed),
        cmocka_unit_test(sealed_box_is_dark),
        cmocka_unit_test(raster_equals_rays),
        cmocka_unit_test(a_ground_without_end_is_flat),
        cmocka_unit_test(shortcuts_change_nothing),
        cmocka_unit_test(penumbra_has_its_width),
        cmocka_unit_test(points_draw_by_seed_and_place),
        cmocka_unit_test(clusters_sum_to_the_same),
        cmocka_unit_test(texels_are_snapped),
        cmocka_unit_test(clip_spaces_meet_the_lookup),
        cmocka_unit_test(cost_model_finds_the_best),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
