/* options_test - what single fields do: clip conventions of a view, rules near by against closed form and brute
   force, shares and blur of the choice, shares and numbers of points. Each fails if its field did nothing. */

#include "ism.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>
#include "util.h"

#define CLOSE(a, b, tolerance) close_to(__LINE__, (double)(a), (double)(b), (double)(tolerance))

static soup mesh;
static grid lit, eye;

static void close_to(int line, double a, double b, double tolerance)
{
    if (!(fabs(a - b) <= tolerance)) fail_msg("line %d: %g, not %g +- %g", line, a, b, tolerance);
}

static const float up[3] = { 0, 1, 0 }, down[3] = { 0, -1, 0 };

/* A floor of 4 x 4 m, n x n texels, under a ceiling of w x h receivers 2 m above. */
static ism_frame floor_and_ceiling(uint32_t n, uint32_t w, uint32_t h, ism_source *s, ism_points *view)
{
    const float a[3] = { -2, 0, -2 }, high[3] = { -2, 2, -2 }, u[3] = { 4, 0, 0 }, v[3] = { 0, 0, 4 };
    ism_frame f;
    grid_fill(&lit, n, n, a, u, v, up, 1);
    grid_fill(&eye, w, h, high, u, v, down, 0);
    *s = grid_source(&lit);
    *view = grid_view(&eye);
    memset(&f, 0, sizeof f);
    f.sources = s;
    f.source_count = 1;
    f.points = view;
    return f;
}

/* Chooses with d; the importances into out, scaled to a sum of 1. */
static void importances(const ism_desc *d, const ism_frame *f, double *out)
{
    ism_maps *m;
    const float *from;
    size_t count, i;
    double sum = 0;
    assert_int_equal(ism_create(d, &m), ISM_OK);
    assert_int_equal(ism_choose(m, f), ISM_OK);
    from = ism_importances(m, 0, &count);
    assert_int_equal(count, f->sources[0].width * f->sources[0].height);
    for (i = 0; i < count; i++) sum += (double)from[i];
    for (i = 0; i < count; i++) out[i] = (double)from[i] / sum;
    ism_free(m);
}

static double largest_difference(const double *a, const double *b, size_t count)
{
    double worst = 0;
    size_t i;
    for (i = 0; i < count; i++) worst = fmax(worst, fabs(a[i] - b[i]));
    return worst;
}

/* ---- view ---- */

/* Looked at from below, x to the right and z to the picture's foot: row 0 has z = -2, which is clip y = 1. */
static void clip_conventions_give_the_same_choice(void **state)
{
    static double gl[256], other[256];
    ism_source s;
    ism_points view;
    ism_frame f = floor_and_ceiling(16, 32, 32, &s, &view);
    ism_desc d;
    int k;
    (void)state;
    memset(&d, 0, sizeof d);
    d.vpl_count = 16;
    d.importance = ISM_IMPORTANCE_GUIDED;
    view.world_to_clip[0] = 0.5f;          /* x / 2; -z / 2; 0.2 y - 0.3; 1 */
    view.world_to_clip[9] = -0.5f;
    view.world_to_clip[6] = 0.2f;
    view.world_to_clip[14] = -0.3f;
    view.world_to_clip[15] = 1;
    view.rows = ISM_ROWS_TOP_FIRST;
    importances(&d, &f, gl);
    for (k = 0; k < 4; k++)         /* z' = (z + w) / 2, as Vulkan and Direct3D have it: depth is not read */
        view.world_to_clip[4 * k + 2] = 0.5f * (view.world_to_clip[4 * k + 2] + view.world_to_clip[4 * k + 3]);
    importances(&d, &f, other);
    assert_memory_equal(gl, other, sizeof gl);
    view.world_to_clip[9] = 0.5f;
    view.rows = ISM_ROWS_BOTTOM_FIRST;
    importances(&d, &f, other);
    CLOSE(largest_difference(gl, other, 256), 0, 1e-6);
    view.rows = ISM_ROWS_TOP_FIRST;        /* the wrong flag mirrors the places that samples are drawn about */
    importances(&d, &f, other);
    assert_true(largest_difference(gl, other, 256) > 1e-4);
}

/* ---- rules near by ---- */

/* VPLs of `flux` at heights over one receiver that looks up, no shadows: irradiance and share lost. */
static double light_of(const ism_vpl *vpls, size_t count, const float normal[3], ism_near rule, float clamp,
                       double *lost)
{
    const float at[3] = { 0, 0, 0 };
    ism_shading s = { 0 };
    ism_stats stats;
    ism_points view;
    ism_desc d;
    ism_maps *m;
    float light[3];
    memset(&view, 0, sizeof view);
    memset(&d, 0, sizeof d);
    view.positions = at;
    view.normals = normal;
    view.count = 1;
    d.vpl_count = (uint32_t)count;
    s.near_mode = rule;
    s.clamp = clamp;
    s.no_maps = 1;
    assert_int_equal(ism_create(&d, &m), ISM_OK);
    assert_int_equal(ism_set_vpls(m, vpls, count), ISM_OK);
    assert_int_equal(ism_shade(m, &view, &s, light, &stats), ISM_OK);
    *lost = stats.lost_energy;
    ism_free(m);
    return (double)light[0];
}

/* The integral of cos cos over the sphere's cone over pi r^2, r that of a disc of the VPL's area. Facing each other:
   2 (1 - c^3) / (3 r^2), c the cosine of the cone's half angle; inside the sphere the hemisphere, 2 / (3 r^2). */
static void a_spherical_light_is_its_integral(void **state)
{
    static const double distances[] = { 0.3, 1.1, 1.5, 2, 4, 6.5, 9 };     /* in radii; from 7.09 on it is a point */
    const double area = 0.2, r2 = area / UTIL_PI;
    size_t i;
    (void)state;
    for (i = 0; i < sizeof distances / sizeof distances[0]; i++) {
        double t = distances[i], d2 = t * t * r2, c = t > 1 ? sqrt(1 - 1 / (t * t)) : 0, lost;
        double kernel = 2 * (1 - c * c * c) / (3 * r2), light, plain = 1 / d2;
        ism_vpl v = util_vpl(0, (float)sqrt(d2), 0, 0, -1, 0, (float)UTIL_PI);
        v.area = (float)area;
        if (d2 > 16 * area) kernel = plain;
        light = light_of(&v, 1, up, ISM_NEAR_SPHERE, 1, &lost);
        /* midpoints of 16 rings: 1/16^2 / 12 of cos^2, 8 of them inside the sphere */
        CLOSE(light / kernel, 1, t > 1 ? 1e-3 : 5e-3);
        CLOSE(lost, fmax(1 - kernel / plain, 0), t > 1 ? 1e-3 : 5e-3);
    }
}

/* The same where both are turned, against a sum over 200 x 400 parts of the cone. 16 samples stand for it: 3 %. */
static void a_spherical_light_aslant_is_the_sum_over_its_cone(void **state)
{
    const float normal[3] = { 0.6f, 0.8f, 0 };
    const double area = 0.2, r2 = area / UTIL_PI, d2 = 4 * r2, least = sqrt(1 - r2 / d2);
    double sum = 0, lost, light;
    ism_vpl v = util_vpl(0, (float)sqrt(d2), 0, 0, -0.8f, 0.6f, (float)UTIL_PI);
    int i, j;
    (void)state;
    v.area = (float)area;
    for (i = 0; i < 200; i++)
        for (j = 0; j < 400; j++) {
            double y = 1 - (1 - least) * (i + 0.5) / 200, s = sqrt(1 - y * y), phi = 2 * UTIL_PI * (j + 0.5) / 400;
            double x = s * cos(phi), z = s * sin(phi), a = 0.6 * x + 0.8 * y, b = 0.8 * y - 0.6 * z;
            if (a > 0 && b > 0) sum += a * b / 80000;
        }
    light = light_of(&v, 1, normal, ISM_NEAR_SPHERE, 1, &lost);
    CLOSE(light / (sum * 2 * (1 - least) / r2), 1, 0.03);
    CLOSE(lost, 1 - light * d2 / 0.64, 1e-5);
}

static void lights_are_clamped_to_their_mean(void **state)
{
    enum { N = 50 };
    static ism_vpl v[N];
    double light[N], mean = 0, sum, over, lost, e;
    float clamp;
    int i;
    (void)state;
    for (i = 0; i < N; i++) {
        float y = 0.1f + 0.05f * (float)i, flux = 0.2f + 0.013f * (float)(i * 7 % N);
        v[i] = util_vpl(0, y, 0, 0, -1, 0, flux);
        light[i] = (double)flux / ((double)y * (double)y);
        mean += light[i] / N;
    }
    for (clamp = 0.5f; clamp < 100; clamp *= 3) {
        sum = over = 0;
        for (i = 0; i < N; i++) {
            sum += fmin(light[i], (double)clamp * mean);
            over += fmax(light[i] - (double)clamp * mean, 0);
        }
        e = light_of(v, N, up, ISM_NEAR_CLAMP_MEAN, clamp, &lost);
        CLOSE(e * UTIL_PI / sum, 1, 1e-5);
        CLOSE(lost, over / (sum + over), 1e-5);
    }
    assert_true(over <= 0);         /* the last clamp cuts nothing; the first one most */
}

/* ---- the choice ---- */

/* Four pixels, a cell of the grid each, so that every sample sees the pixel's one normal; two texels of a sky, whose
   effect is the cosine. All pixels are lit by the second at 60 degrees, one alone by the first, at 30: the means are
   0.2165 and 0.5, the roots of the mean squares 0.4330 and 0.5. */
static void the_mean_is_the_mean_and_not_its_root(void **state)
{
    static const float places[12] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0 };
    static const float normals[12] = { 0.8660254f, 0, 0.5f, -0.8660254f, 0, 0.5f, 0, 0.8660254f, 0.5f,
                                       0, -0.8660254f, 0.5f };
    static const float to_sky[6] = { 1, 0, 0, 0, 0, 1 }, fluxes[6] = { 1, 1, 1, 1, 1, 1 };
    static const ism_importance kinds[4] = { ISM_IMPORTANCE_BRSM, ISM_IMPORTANCE_BRSM_MEAN, ISM_IMPORTANCE_GUIDED,
                                             ISM_IMPORTANCE_GUIDED_MEAN };
    ism_points view;
    ism_source s;
    ism_frame f;
    int i;
    (void)state;
    memset(&view, 0, sizeof view);
    memset(&s, 0, sizeof s);
    memset(&f, 0, sizeof f);
    view.count = 4;
    view.width = 2;
    view.positions = places;
    view.normals = normals;
    s.kind = ISM_SOURCE_DIRECTIONS;
    s.width = 2;
    s.height = 1;
    s.positions = to_sky;
    s.fluxes = fluxes;
    f.sources = &s;
    f.source_count = 1;
    f.points = &view;
    for (i = 0; i < 4; i++) {
        double all[2], first = i & 1 ? 0.25 * 0.8660254 : 0.5 * 0.8660254;
        ism_desc d;
        memset(&d, 0, sizeof d);
        d.vpl_count = 1;
        d.importance = kinds[i];
        d.view_grid_side = 2;
        d.flux_share = 1e-6f;
        importances(&d, &f, all);
        CLOSE(all[0], first / (first + 0.5), 1e-5);
    }
}

/* A floor whose every texel has another effect on the ceiling: over many seeds the mean on samples is the mean over all
   pixels, which is summed here, within four deviations. */
static void the_mean_on_samples_is_the_mean_over_the_picture(void **state)
{
    enum { SEEDS = 400, SIDE = 8, TEXELS = SIDE * SIDE };
    static double sum[TEXELS], square[TEXELS], all[TEXELS], exact[TEXELS];
    ism_source s;
    ism_points view;
    ism_frame f = floor_and_ceiling(SIDE, 32, 32, &s, &view);
    const double extent2 = 32 * (31.0 / 32) * (31.0 / 32);   /* of centres of pixels of 4 x 4 */
    double total = 0;
    uint32_t seed;
    size_t i, j;
    int k;
    (void)state;
    for (i = 0; i < TEXELS; i++) {
        for (j = 0, exact[i] = 0; j < view.count; j++) {
            double d2 = 1e-4 * extent2, height = 0;
            for (k = 0; k < 3; k++) {
                double d = (double)lit.p[3 * i + (size_t)k] - (double)eye.p[3 * j + (size_t)k];
                d2 += d * d;
                if (k == 1) height = d;
            }
            exact[i] += height * height / (d2 * d2);
        }
        total += exact[i];
    }
    memset(sum, 0, sizeof sum);
    memset(square, 0, sizeof square);
    for (seed = 0; seed < SEEDS; seed++) {
        ism_desc d;
        memset(&d, 0, sizeof d);
        d.vpl_count = 1;
        d.importance = ISM_IMPORTANCE_BRSM_MEAN;
        d.flux_share = 1e-6f;
        d.blur_radius = -1;
        d.seed = seed;
        importances(&d, &f, all);
        for (i = 0; i < TEXELS; i++) {
            sum[i] += all[i] / SEEDS;
            square[i] += all[i] * all[i] / SEEDS;
        }
    }
    for (i = 0; i < TEXELS; i++) {
        double sigma = sqrt(fmax(square[i] - sum[i] * sum[i], 0) / SEEDS);
        assert_true(sigma < 0.02 * sum[i]);
        CLOSE(sum[i], exact[i] / total, 4 * sigma + 0.002 * exact[i] / total);
    }
}

static ism_desc by_brsm(float flux_share)
{
    ism_desc d;
    memset(&d, 0, sizeof d);
    d.vpl_count = 16;
    d.importance = ISM_IMPORTANCE_BRSM;
    d.flux_share = flux_share;
    return d;
}

/* Half of the floor looks down: nothing of its light reaches the ceiling, so that flux alone speaks for it. The share
   of the sum: s / (1 + s / 1000), which keeps the factor of s = 1 finite. */
static void flux_keeps_its_share(void **state)
{
    static const float shares[] = { 0, 0.1f, 0.4f, 1 };
    static double all[256];
    ism_source s;
    ism_points view;
    ism_frame f = floor_and_ceiling(16, 16, 16, &s, &view);
    ism_desc d = by_brsm(0);
    size_t i, k;
    (void)state;
    d.blur_radius = -1;
    for (i = 0; i < 128; i++) lit.n[3 * i + 1] = -1;
    for (k = 0; k < 4; k++) {
        double dark = 0, share = k ? (double)shares[k] : 0.1;
        d.flux_share = shares[k];
        importances(&d, &f, all);
        for (i = 0; i < 128; i++) dark += all[i];
        CLOSE(dark, 0.5 * share / (1 + 0.001 * share), 1e-4);
    }
}

/* The same floor as two sources, one of which reaches nothing: the share is of both together. By itself each had its
   own, and one with a few great effects left the others nothing. */
static void flux_keeps_its_share_of_all_sources(void **state)
{
    ism_source whole, halves[2];
    ism_points view;
    ism_frame f = floor_and_ceiling(16, 16, 16, &whole, &view);
    ism_desc d = by_brsm(0.4f);
    double sums[2] = { 0, 0 };
    ism_maps *m;
    (void)state;
    d.blur_radius = -1;
    for (size_t i = 0; i < 128; i++) lit.n[3 * i + 1] = -1;
    for (size_t k = 0; k < 2; k++) {
        halves[k] = whole;
        halves[k].height = 8;
        halves[k].positions = lit.p + 3 * 128 * k;
        halves[k].normals = lit.n + 3 * 128 * k;
        halves[k].fluxes = lit.f + 3 * 128 * k;
        if (whole.areas) halves[k].areas = whole.areas + 128 * k;
    }
    f.sources = halves;
    f.source_count = 2;
    assert_int_equal(ism_create(&d, &m), ISM_OK);
    assert_int_equal(ism_choose(m, &f), ISM_OK);
    for (size_t k = 0; k < 2; k++) {
        size_t count;
        const float *all = ism_importances(m, k, &count);
        assert_int_equal(count, 128);
        for (size_t i = 0; i < count; i++) sums[k] += (double)all[i];
    }
    CLOSE(sums[0] / (sums[0] + sums[1]), 0.5 * 0.4 / (1 + 0.001 * 0.4), 1e-4);
    ism_free(m);
}

/* One texel of 41 x 41 that sees the ceiling, the others' places being the same: with radius r it is spread over a
   square of 2 r + 1. The normals about it are turned by less than 60 degrees, so that they mix, but see nothing. */
static void effects_are_blurred_by_the_radius(void **state)
{
    static const uint32_t radii[] = { 0, 1, 3, 6 };
    static double all[41 * 41];
    ism_source s;
    ism_points view;
    ism_frame f = floor_and_ceiling(41, 8, 8, &s, &view);
    ism_desc d = by_brsm(1e-6f);
    size_t i, k;
    (void)state;
    for (i = 0; i < 41 * 41; i++) {         /* at one place: nothing but the effect differs */
        lit.p[3 * i] = lit.p[3 * i + 1] = lit.p[3 * i + 2] = 0;
        lit.n[3 * i] = i == 20 * 41 + 20 ? 0.0f : 0.8f;
        lit.n[3 * i + 1] = i == 20 * 41 + 20 ? 1.0f : 0.6f;
    }
    for (i = 0; i < 64; i++) {              /* where the turned ones do not look */
        eye.p[3 * i] = -3;
        eye.p[3 * i + 1] = 2;
        eye.p[3 * i + 2] = 0;
    }
    for (k = 0; k < 5; k++) {
        size_t above = 0, side = k < 4 ? 2 * radii[k] + 1 : 1;
        d.blur_radius = k < 4 ? (int32_t)radii[k] : -3;
        if (k == 0) side = 2 * 2 + 1;                       /* 5 % of 41 texels */
        importances(&d, &f, all);
        for (i = 0; i < 41 * 41; i++) above += all[i] > 1e-5;
        if (above != side * side)
            fail_msg("blur_radius %d: %u texels, not %u", (int)d.blur_radius, (unsigned)above, (unsigned)(side * side));
    }
}

/* All texels at one place have one effect: what differs is noise of the view samples, about 1 / grid^2 of them for a
   jittered grid. */
static void more_view_samples_make_less_noise(void **state)
{
    static double all[256];
    double spread[2];
    ism_source s;
    ism_points view;
    ism_frame f = floor_and_ceiling(16, 64, 64, &s, &view);
    ism_desc d;
    size_t i;
    int k;
    (void)state;
    memset(&d, 0, sizeof d);
    d.vpl_count = 16;
    d.importance = ISM_IMPORTANCE_BRSM;
    d.blur_radius = -1;
    d.flux_share = 1e-6f;
    for (i = 0; i < 256; i++) lit.p[3 * i] = lit.p[3 * i + 2] = 0.3f;
    for (k = 0; k < 2; k++) {
        double square = 0;
        d.view_grid_side = k ? 8 : 2;
        importances(&d, &f, all);
        for (i = 0; i < 256; i++) square += (256 * all[i] - 1) * (256 * all[i] - 1) / 256;
        spread[k] = sqrt(square);
    }
    print_message("view_grid 2: spread %.4f, 8: %.4f\n", spread[0], spread[1]);
    assert_true(spread[0] > 0.02 && spread[1] < spread[0] / 4);
}

/* ---- points ---- */

/* A sheet that faces the only receiver and one of thrice its area seen edge-on: of that no solid angle is left, so that
   area alone puts points there. */
static void area_keeps_its_share_of_points(void **state)
{
    enum { VPLS = 16, POINTS = 1024 };
    static const float shares[] = { 0, 0.2f, 0.5f, 1 };
    static ism_surfel points[POINTS];
    const float a[3] = { 1, -1, -1 }, y[3] = { 0, 2, 0 }, z[3] = { 0, 0, 2 };
    const float edge[3] = { 2, 0, -1 }, x[3] = { 6, 0, 0 }, at[3] = { 0, 0, 0 };
    ism_vpl vpls[VPLS];
    ism_points view;
    ism_frame f;
    ism_mesh m;
    size_t i, k, count;
    (void)state;
    mesh.triangles = 0;
    soup_quad(&mesh, a, z, y, 1);           /* triangles 0 and 1: 4 m^2; 2 and 3: 12 m^2 */
    soup_quad(&mesh, edge, x, z, 1);
    m = soup_mesh(&mesh);
    memset(&view, 0, sizeof view);
    memset(&f, 0, sizeof f);
    view.positions = at;
    view.normals = up;
    view.count = 1;
    f.mesh = &m;
    f.points = &view;
    for (i = 0; i < VPLS; i++) vpls[i] = util_vpl(0, 3, 0, 0, -1, 0, 1);
    for (k = 0; k < 4; k++) {
        double share = k ? (double)shares[k] : 0.2, found = 0;
        ism_desc d;
        ism_maps *maps;
        uint32_t v;
        memset(&d, 0, sizeof d);
        d.vpl_count = VPLS;
        d.surfel_count = POINTS;
        d.tile_side = 8;
        d.spread = ISM_SPREAD_VIEW_1;
        d.area_share = shares[k];
        assert_int_equal(ism_create(&d, &maps), ISM_OK);
        assert_int_equal(ism_set_vpls(maps, vpls, VPLS), ISM_OK);
        assert_int_equal(ism_scatter(maps, &f), ISM_OK);
        for (v = 0; v < VPLS; v++) {
            assert_int_equal(ism_surfels(maps, v, points, POINTS, &count), ISM_OK);
            assert_int_equal(count, POINTS);
            for (i = 0; i < count; i++) found += (double)(points[i].triangle >= 2) / (VPLS * POINTS);
        }
        CLOSE(found, 0.75 * share, 0.015);  /* 4 deviations of 16,384 independent points at most */
        ism_free(maps);
    }
}

/* A VPL of less than half of the mean power takes half of the points, of less than a quarter a quarter; they stand for
   all of the surface none the less. */
static void weak_vpls_take_fewer_points(void **state)
{
    static const uint32_t expected[4] = { 64, 64, 32, 16 };
    static const float powers[4] = { 2, 1, 0.45f, 0.2f };       /* mean 0.9125 */
    const float lo[3] = { -1, 1, -1 }, hi[3] = { 1, 2, 1 };
    ism_surfel points[64];
    ism_vpl vpls[4];
    ism_source s;
    ism_points view;
    ism_frame f = floor_and_ceiling(4, 4, 4, &s, &view);
    ism_mesh m;
    int vary;
    (void)state;
    mesh.triangles = 0;
    soup_box(&mesh, lo, hi, 1, 1);          /* 16 m^2: 8 triangles of 1 m^2, 4 of 2 */
    m = soup_mesh(&mesh);
    f.mesh = &m;
    for (vary = 0; vary < 2; vary++) {
        ism_desc d;
        ism_maps *maps;
        uint32_t v;
        memset(&d, 0, sizeof d);
        d.vpl_count = 4;
        d.surfel_count = 64;
        d.tile_side = 8;
        d.spread = ISM_SPREAD_AREA;
        d.vary_surfels = vary;
        for (v = 0; v < 4; v++) vpls[v] = util_vpl(0, 0, 0, 0, 1, 0, powers[v]);
        assert_int_equal(ism_create(&d, &maps), ISM_OK);
        assert_int_equal(ism_set_vpls(maps, vpls, 4), ISM_OK);
        assert_int_equal(ism_scatter(maps, &f), ISM_OK);
        for (v = 0; v < 4; v++) {
            size_t count, i;
            double area = 0;
            assert_int_equal(ism_surfels(maps, v, points, 64, &count), ISM_OK);
            assert_int_equal(count, vary ? expected[v] : 64);
            for (i = 0; i < count; i++) {
                const float *p = m.positions + 9 * points[i].triangle;
                double a[3], b[3], n[3];
                int k;
                for (k = 0; k < 3; k++) {
                    a[k] = (double)(p[3 + k] - p[k]);
                    b[k] = (double)(p[6 + k] - p[k]);
                }
                for (k = 0; k < 3; k++) n[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
                area += 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) * (double)points[i].area;
            }
            CLOSE(area / 16, 1, 1e-3);      /* each point stands for area / n */
        }
        ism_free(maps);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clip_conventions_give_the_same_choice), cmocka_unit_test(a_spherical_light_is_its_integral),
        cmocka_unit_test(a_spherical_light_aslant_is_the_sum_over_its_cone),
        cmocka_unit_test(lights_are_clamped_to_their_mean),
        cmocka_unit_test(the_mean_is_the_mean_and_not_its_root),
        cmocka_unit_test(the_mean_on_samples_is_the_mean_over_the_picture),
        cmocka_unit_test(flux_keeps_its_share), cmocka_unit_test(flux_keeps_its_share_of_all_sources),
        cmocka_unit_test(effects_are_blurred_by_the_radius), cmocka_unit_test(more_view_samples_make_less_noise),
        cmocka_unit_test(area_keeps_its_share_of_points), cmocka_unit_test(weak_vpls_take_fewer_points),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
