/* ism_formulas_test - the closed forms that ism.h is made of: distributions (T15, T16), form factors (T42, T43), maps
   of the hemisphere (T46, T47), sampling of triangles (T51), solid angles (T52), dither (T58). */

#define ISM_IMPLEMENTATION
#include "ism.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "conformance.h"
#include "unit/ism_util.h"

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
    ism_view view;
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
    f.view = &view;
    assert_int_equal(ism_create(&d, &m), ISM_OK);
    assert_int_equal(ism_choose(m, &f), ISM_OK);
    list = ism_vpls(m, &n);
    for (i = 0; i < n; i++) first_texel += list[i].texel == 0;
    assert_int_equal(n, 1024);
    CONFORM("T15", "VPLs at the empty one of two texels", 0, (double)first_texel, 0);
    ism_destroy(m);
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
            ism__draw_vpls(m, &f, of, of[0].total);
            list = ism_vpls(m, &n);
            hits[list[0].texel]++;
        }
        if (f.index % 4096 == 4095) ism_destroy(m);
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

/* ---- T42, T43 ---- */

static void form_factors(void **state)
{
    enum { N = 256 };
    static const float face[12] = { 0, 1, 0,  1, 1, 0,  1, 1, 1,  0, 1, 1 };    /* seen from below */
    static const float wall[12] = { 0, 0, 0,  0, 1, 0,  0, 1, 1,  0, 0, 1 };
    double opposite = 0, edge = 0, sides = 0, corner, middle;
    const float up[3] = { 0, 1, 0 };
    float at[3], c[12];
    int x, y, k, side;
    (void)state;
    for (y = 0; y < N; y++)
        for (x = 0; x < N; x++) {
            at[0] = ((float)x + 0.5f) / N;
            at[1] = 0;
            at[2] = ((float)y + 0.5f) / N;
            for (k = 0; k < 12; k++) c[k] = face[k] - at[k % 3];
            opposite += (double)ism_form_factor(up, c) / (N * N);
            for (k = 0; k < 12; k++) c[k] = wall[k] - at[k % 3];
            edge += (double)ism_form_factor(up, c) / (N * N);
            for (side = 0; side < 4; side++) {
                static const float sign[4] = { 1, -1, 1, -1 };
                for (k = 0; k < 4; k++) {       /* the four walls of the cube, turned round its axis */
                    int from = side % 2 ? 3 - k : k;
                    float wy = wall[3 * from + 1], wz = wall[3 * from + 2], wx = sign[side] > 0 ? 0.0f : 1.0f;
                    c[3 * k] = (side < 2 ? wx : 1 - wz) - at[0];
                    c[3 * k + 1] = wy - at[1];
                    c[3 * k + 2] = (side < 2 ? wz : wx) - at[2];
                }
                sides += (double)ism_form_factor(up, c) / (N * N);
            }
        }
    /* midpoint sums of 256^2: the integrand has a kink at the shared edge only, 1e-4 there */
    CONFORM("T42", "two unit squares 1 apart", 0.1998249, opposite, 1e-5);
    CONFORM("T42", "two unit squares that share an edge", 0.2000438, edge, 2e-4);
    CONFORM("T42", "one face of a cube to the other five", 1, opposite + sides, 1e-3);
    for (k = 0; k < 12; k++) c[k] = face[k] - (k % 3 == 1 ? 0.0f : 0.5f);
    middle = (double)ism_form_factor(up, c);
    corner = (double)ism_form_factor(up, face);
    CONFORM("T43", "unit square 1 above, its centre", 0.239456, middle, 1e-6);
    CONFORM("T43", "unit square 1 above, its corner", 0.138532, corner, 1e-6);
}

/* ---- T46, T47 ---- */

static void maps_of_the_hemisphere(void **state)
{
    enum { T = 32, SUB = 16 };
    static const char *const names[5] = { "", "cosine", "paraboloid", "octahedral", "lobe" };
    int p, x, y, i, j, k, below = 0;
    (void)state;
    for (p = 1; p < ISM_PROJECTION_COUNT; p++) {
        double solid = 0, cosine = 0, worst = 0, least = 1e9, most = 0, round_trip = 0;
        float exponent = 3;
        char text[80];
        for (y = 0; y < T; y++)
            for (x = 0; x < T; x++) {
                double weight = 0;
                for (j = 0; j < SUB; j++)
                    for (i = 0; i < SUB; i++) {
                        const float h = 1.0f / (T * SUB);
                        float d[4][3], uv[2], back[2];
                        double a[3], b[3], n[3], area, z;
                        for (k = 0; k < 4; k++) {
                            uv[0] = ((float)(x * SUB + i) + (k == 1 || k == 2 ? 1.0f : 0.0f)) * h;
                            uv[1] = ((float)(y * SUB + j) + (k >= 2 ? 1.0f : 0.0f)) * h;
                            ism_map_direction((ism_projection)p, exponent, uv, d[k]);
                        }
                        for (k = 0; k < 3; k++) {
                            a[k] = (double)d[2][k] - (double)d[0][k];
                            b[k] = (double)d[3][k] - (double)d[1][k];
                        }
                        for (k = 0; k < 3; k++)
                            n[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
                        area = 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
                        z = ((double)d[0][2] + (double)d[1][2] + (double)d[2][2] + (double)d[3][2]) / 4;
                        if (z <= 0) continue;
                        solid += area;
                        cosine += area * z;
                        weight += area * (p == ISM_PROJECTION_LOBE ? pow(z, 3) : z);
                        uv[0] = ((float)(x * SUB + i) + 0.5f) * h;
                        uv[1] = ((float)(y * SUB + j) + 0.5f) * h;
                        ism_map_direction((ism_projection)p, exponent, uv, d[0]);
                        if (d[0][2] > 1e-3f && ism_map_coordinates((ism_projection)p, exponent, d[0], back)) {
                            float again[3];
                            ism_map_direction((ism_projection)p, exponent, back, again);
                            for (k = 0; k < 3; k++)
                                if (fabs((double)again[k] - (double)d[0][k]) > round_trip)
                                    round_trip = fabs((double)again[k] - (double)d[0][k]);
                        }
                    }
                if (weight < least) least = weight;
                if (weight > most) most = weight;
            }
        /* facets of 1/512 of the square; at the rim of a map the disc is cut by whole facets */
        snprintf(text, sizeof text, "%s map, solid angles of the texels", names[p]);
        if (p != ISM_PROJECTION_LOBE) CONFORM("T46", text, 2 * UTIL_PI, solid, 0.02);
        snprintf(text, sizeof text, "%s map, cosine-weighted", names[p]);
        if (p != ISM_PROJECTION_LOBE) CONFORM("T46", text, UTIL_PI, cosine, 0.003);
        snprintf(text, sizeof text, "%s map, round trip", names[p]);
        CONFORM_MAX("T46", text, 1e-5, round_trip);
        worst = most / least - 1;
        if (p == ISM_PROJECTION_COSINE) {
            CONFORM("T47", "cosine map, weight of a texel x T / pi, least", 1, least * T * T / UTIL_PI, 0.005);
            CONFORM("T47", "cosine map, weight of a texel x T / pi, most", 1, most * T * T / UTIL_PI, 0.005);
        }
        /* facets at the horizon are chords of where cos^3 is almost 0 */
        if (p == ISM_PROJECTION_LOBE) CONFORM_MAX("T47", "lobe map, exponent 3, spread of texel weights", 0.08, worst);
        for (i = 0; i < 1000; i++) {
            float a = (float)i * 0.00628f, d[3], uv[2] = { -1, -1 };
            d[0] = cosf(a);
            d[1] = sinf(a);
            d[2] = i % 2 ? 0.0f : -1e-6f;
            below += ism_map_coordinates((ism_projection)p, exponent, d, uv) || uv[0] > -1;
        }
    }
    CONFORM("T46", "directions at and below the horizon that get coordinates", 0, below, 0);
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
        ism__triangle_map(ism__random(1, 2, (uint32_t)i), ism__random(1, 3, (uint32_t)i), &b1, &b2);
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

static void solid_angles(void **state)
{
    static const float x[3] = { 3, 0, 0 }, y[3] = { 0, 0.5f, 0 }, z[3] = { 0, 0, 7 };
    static soup s;
    const float lo[3] = { -0.3f, -2, -1 }, hi[3] = { 1.7f, 0.2f, 5 };
    double sum = 0;
    size_t t;
    (void)state;
    CONFORM("T52", "octant triangle", UTIL_PI / 2, ism_solid_angle(x, y, z), 1e-6);
    CONFORM("T52", "degenerate triangle", 0, ism_solid_angle(x, x, z) + ism_solid_angle(x, y, x), 0);
    s.triangles = 0;
    soup_box(&s, lo, hi, -1, 3);
    for (t = 0; t < s.triangles; t++) sum += (double)ism_solid_angle(s.p + 9 * t, s.p + 9 * t + 3, s.p + 9 * t + 6);
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
            for (x = 0; x < 2; x++) drawn += ism_dither((uint32_t)x + 6, (uint32_t)y + 10, 0.25f * (float)level);
        wrong += drawn != level;
    }
    CONFORM("T58", "levels of 0, .25, .5, .75, 1 over 2 x 2 pixels that are not exact", 0, wrong, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(choice_follows_the_distribution),
        cmocka_unit_test(sums_are_not_of_floats),
        cmocka_unit_test(form_factors),
        cmocka_unit_test(maps_of_the_hemisphere),
        cmocka_unit_test(triangles_are_sampled_evenly),
        cmocka_unit_test(solid_angles),
        cmocka_unit_test(dither_has_five_levels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
