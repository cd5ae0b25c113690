/* formulas_rows_test - the closed forms that ism.h alone is made of: distributions (T15, T16), sampling of triangles
   (T51), solid angles (T52), dither (T58). */

#define ISM_STATIC
#define ISM_IMPLEMENTATION
#include "ism.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "conformance.h"
#include "src/shared/rng.h"
#include "util.h"

/* ---- T15, T16: VPLs come from the distribution ---- */

static void choice_follows_the_distribution(void **state)
{
    static grid g;
    const float a[3] = { 0, 0, 0 }, u[3] = { 1, 0, 0 }, v[3] = { 0, 0, 1 }, up[3] = { 0, 1, 0 };
    static grid eye;
    static uint32_t hits[64 * 32];
    ism_desc d;
    ism_maps *m;
    ism_source s;
    ism_points view;
    ism_frame f;
    const ism_vpl *list;
    size_t n, i, first_texel = 0;
    double total = 0, chi2 = 0, p;
    uint32_t seed = 5;
    (void)state;
    grid_fill(&eye, 1, 1, a, u, v, up, 0);
    view = grid_view(&eye);
    memset(&d, 0, sizeof d);
    d.importance = ISM_IMPORTANCE_FLUX;
    d.no_inter_texel = 1;
    /* two texels (0, 1): never the first */
    grid_fill(&g, 2, 1, a, u, v, up, 0);
    g.f[3] = g.f[4] = g.f[5] = 1;
    s = grid_source(&g);
    memset(&f, 0, sizeof f);
    f.sources = &s;
    f.source_count = 1;
    f.points = &view;
    assert_int_equal(ism_create(&d, &m), ISM_OK);
    assert_int_equal(ism_choose(m, &f), ISM_OK);
    list = ism_vpls(m, &n);
    for (i = 0; i < n; i++) first_texel += list[i].texel == 0;
    assert_int_equal(n, 1024);
    CONFORM("T15", "VPLs at the empty one of two texels", 0, (double)first_texel, 0);
    ism_free(m);
    /* chi-square of 64 x 32 texels of random weight, 16384 independent choices */
    grid_fill(&g, 64, 32, a, u, v, up, 0);
    for (i = 0; i < 64 * 32; i++) {
        float w = 0.2f + util_unit(&seed);
        g.f[3 * i] = g.f[3 * i + 1] = g.f[3 * i + 2] = w;
        total += (double)w;
    }
    s = grid_source(&g);
    d.vpl_count = 1;
    d.unstable = 1;
    memset(hits, 0, sizeof hits);
    for (f.index = 0; f.index < 16384; f.index++) {
        if (f.index % 4096 == 0) {       /* choosing is O(texels): keep one table, draw by it */
            assert_int_equal(ism_create(&d, &m), ISM_OK);
            assert_int_equal(ism_choose(m, &f), ISM_OK);
            assert_non_null(ism_importances(m, 0, &n));
            assert_int_equal(n, 64 * 32);
        }
        {
            const ism__source_of *of = (const ism__source_of *)m->sources.data;
            ism__job job;
            ism__begin_job(&m->desc.system, "", &f, &job);
            ism__draw_all_vpls(m, &job, of[0].total);
            list = ism_vpls(m, &n);
            hits[list[0].texel]++;
        }
        if (f.index % 4096 == 4095) ism_free(m);
    }
    for (i = 0; i < 64 * 32; i++) {
        double expected = 16384 * (double)g.f[3 * i] / total, e = (double)hits[i] - expected;
        chi2 += e * e / expected;
    }
    p = (chi2 - 2047) / sqrt(2 * 2047.0);       /* normal for so many degrees of freedom; 3.1 is p = 0.001 */
    CONFORM_MAX("T15", "chi-square of VPLs over 64 x 32 texels, standard deviations above its mean", 3.1, p);
}

static void sums_are_not_of_floats(void **state)
{
    static float weights[65536];
    static double sums[65537];
    ism__cdf cdf;
    size_t i;
    (void)state;
    weights[0] = 1000;
    for (i = 1; i < 65536; i++) weights[i] = 1e-5f;
    ism__cdf_build(&cdf, sums, weights, 65536, 1);
    /* a float of 1000 swallows 1e-5 */
    CONFORM("T16", "sum of 1000 and 65,535 times 1e-5", 1000.65535, ism__cdf_total(&cdf), 1e-6);
}

/* ---- T51, T52, T58 ---- */

static void triangles_are_sampled_evenly(void **state)
{
    enum { N = 40000 };
    int part[4] = { 0, 0, 0, 0 }, i;
    double c1 = 0, c2 = 0, outside = 0, worst = 0;
    (void)state;
    for (i = 0; i < N; i++) {
        float b1, b2;
        ism__triangle_map(P_random(1, 2, (uint32_t)i), P_random(1, 3, (uint32_t)i), &b1, &b2);
        outside += b1 < 0 || b2 < 0 || b1 + b2 > 1;
        c1 += (double)b1 / N;
        c2 += (double)b2 / N;
        part[b1 > 0.5f ? 0 : b2 > 0.5f ? 1 : b1 + b2 < 0.5f ? 2 : 3]++;
    }
    for (i = 0; i < 4; i++)
        if (fabs((double)part[i] / N - 0.25) > worst) worst = fabs((double)part[i] / N - 0.25);
    /* 3 sigma of 40,000: centroid 0.0035, share 0.0065 */
    CONFORM("T51", "samples outside the triangle", 0, outside, 0);
    CONFORM("T51", "centroid, first coordinate", 1.0 / 3, c1, 0.0035);
    CONFORM("T51", "centroid, second coordinate", 1.0 / 3, c2, 0.0035);
    CONFORM_MAX("T51", "share of a quarter of the triangle, off by", 0.0065, worst);
}

static void solid_angles_of_a_box_fill_the_sphere(void **state)
{
    static const float x[3] = { 3, 0, 0 }, y[3] = { 0, 0.5f, 0 }, z[3] = { 0, 0, 7 };
    static soup s;
    const float lo[3] = { -0.3f, -2, -1 }, hi[3] = { 1.7f, 0.2f, 5 };
    double sum = 0;
    size_t t;
    (void)state;
    CONFORM("T52", "octant triangle", UTIL_PI / 2, ism__solid_angle(x, y, z), 1e-6);
    CONFORM("T52", "degenerate triangle", 0, ism__solid_angle(x, x, z) + ism__solid_angle(x, y, x), 0);
    s.triangles = 0;
    soup_box(&s, lo, hi, -1, 3);
    for (t = 0; t < s.triangles; t++) sum += (double)ism__solid_angle(s.p + 9 * t, s.p + 9 * t + 3, s.p + 9 * t + 6);
    CONFORM("T52", "closed mesh from inside", 4 * UTIL_PI, sum, 1e-4);   /* atan2: 4e-7 each, 108 triangles */
}

static void dither_has_five_levels(void **state)
{
    int level, x, y;
    double wrong = 0;
    (void)state;
    for (level = 0; level <= 4; level++) {
        int drawn = 0;
        for (y = 0; y < 2; y++)
            for (x = 0; x < 2; x++) drawn += ism__dither((uint32_t)x + 6, (uint32_t)y + 10, 0.25f * (float)level);
        wrong += drawn != level;
    }
    CONFORM("T58", "levels of 0, .25, .5, .75, 1 over 2 x 2 pixels that are not exact", 0, wrong, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(choice_follows_the_distribution),
        cmocka_unit_test(sums_are_not_of_floats),
        cmocka_unit_test(triangles_are_sampled_evenly),
        cmocka_unit_test(solid_angles_of_a_box_fill_the_sphere),
        cmocka_unit_test(dither_has_five_levels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
