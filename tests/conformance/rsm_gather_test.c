/* rsm_gather_test - bounced light of rsm.h against closed forms (rows T25 to T29, T36, T38 to T40, T44 of
   docs/conformance.md), and everything against the sum over all texels. */

#include "rsm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>
#include "conformance.h"
#include "unit/rsm_util.h"

#define ROW(text, pattern) (pattern == RSM_PATTERN_FLUX ? text ", flux" : pattern == RSM_PATTERN_EQUATION3 ? text ", equation (3)" \
                            : pattern == RSM_PATTERN_MIXED ? text ", mixed" : pattern == RSM_PATTERN_LOG_RADIAL ? text ", log-radial" : pattern == RSM_PATTERN_POISSON             \
                            ? text ", Poisson" : text ", low discrepancy")

/* Disc of radius `scale`, albedo 0.5, sun of irradiance 2 straight down, so that rho E0 = 1: the map of T25. */
static rsm_map *disc_map(double scale, uint32_t size)
{
    model m = model_disc(1024, scale);
    rsm_mesh mesh = mesh_of(&m, 0.5);
    rsm_desc d = sun_desc(2, 1.25 * scale, size);
    rsm_map *map = map_of(&d, &mesh, 1, NULL);
    model_free(&m);
    assert_non_null(map);
    return map;
}

static double above(const rsm_map *map, const rsm_gather_desc *g, double height)
{
    return gather_at(map, g, 0, height, 0, 0, -1, 0);
}

/* Mean over seeds: what an unbiased pattern converges to. */
static double mean_above(const rsm_map *map, rsm_gather_desc g, double height, uint32_t seeds)
{
    double sum = 0;
    uint32_t i;
    for (i = 0; i < seeds; i++) {
        g.seed = i;
        sum += above(map, &g, height);
    }
    return sum / seeds;
}

static void one_over_pi(void **state)
{
    rsm_map *map = disc_map(1, 512);
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    int p;
    (void)state;
    /* the rim of the disc in texels: 1e-4 of its area */
    CONFORM("T25", "irradiance over a disc / (rho E0), every texel", 0.5, above(map, &g, 1), 4e-4);
    for (p = RSM_PATTERN_FLUX; p < RSM_PATTERN_COUNT; p++) {
        g = gather_desc((rsm_pattern)p, 4000);
        /* spread of patterns of 4000 over seeds, measured at most 0.004, 8 of them averaged */
        CONFORM("T25", ROW("irradiance over a disc / (rho E0), 4000 samples", p), 0.5, mean_above(map, g, 1, 8), 0.004);
    }
    rsm_map_free(map);
}

static void weights(void **state)
{
    static float pattern[3 * 4096];
    rsm_map *map = disc_map(1, 512);
    int paper, p, i;
    (void)state;
    for (p = RSM_PATTERN_EQUATION3; p < RSM_PATTERN_MIXED; p++)
        for (paper = 0; paper < (p == RSM_PATTERN_EQUATION3 ? 2 : 1); paper++) {
            double inner = 0;
            assert_int_equal(rsm_pattern_build((rsm_pattern)p, 4096, 0, paper, 1, pattern), RSM_OK);
            for (i = 0; i < 4096; i++)
                if (hypot((double)pattern[3 * i], (double)pattern[3 * i + 1]) < 0.5)
                    inner += (double)pattern[3 * i + 2] / PI;
            if (paper) CONFORM("T26", "indicator of the inner half radius, xi^2", 0.125, inner, 0.002);
            else CONFORM("T26", ROW("indicator of the inner half radius", p), 0.25, inner, 0.004);    /* 4096 points */
        }
    {
        rsm_gather_desc g = gather_desc(RSM_PATTERN_EQUATION3, 4096);
        g.r_max = 0.4f;                          /* the disc's own radius in sides of the map */
        CONFORM("T26", "the scene of T25 with xi", 0.5, mean_above(map, g, 1, 8), 0.004);
        g.paper_weights = 1;
        CONFORM("T26", "the scene of T25 with normalised xi^2", 0.428, mean_above(map, g, 1, 8), 0.004);
    }
    rsm_map_free(map);
}

static void normalised(void **state)
{
    rsm_map *map = disc_map(1, 512);
    rsm_gather_desc g = gather_desc(RSM_PATTERN_EQUATION3, 4096);
    rsm_gather_stats stats;
    float p[3] = { 0, 1, 0 }, n[3] = { 0, -1, 0 }, e[3];
    rsm_points points = points_of(p, n, 1, 0);
    double first, other;
    (void)state;
    g.r_max = 0.45f;
    first = mean_above(map, g, 1, 8);
    g.samples = 8192;
    other = mean_above(map, g, 1, 8);
    CONFORM("T27", "result of twice the samples / result", 1, other / first, 0.01);
    g.r_max = 0.9f;
    other = mean_above(map, g, 1, 8);
    CONFORM("T27", "result of twice r_max / result", 1, other / first, 0.01);
    g.r_max = 0.2f;                              /* half the disc's radius: a quarter of its flux remains */
    assert_int_equal(rsm_gather((const rsm_map *const *)&map, 1, &g, &points, e, &stats), RSM_OK);
    CONFORM("T27", "share of the flux beyond r_max = half the disc, as reported", 0.75, stats.outside_share, 2e-3);
    rsm_map_free(map);
}

static void scale_cancels(void **state)
{
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    rsm_map *map = disc_map(2, 512);
    (void)state;
    CONFORM("T28", "the scene of T25 twice as large: irradiance / (rho E0)", 0.5, above(map, &g, 2), 4e-4);
    rsm_map_free(map);
}

/* A pixel light alone: inverse square; and what a map's own shadow blocks is dark in direct light. */
static void falloff(void **state)
{
    static const float quads[] = { -1, 0, -1, 2, 0, 0, 0, 0, 2,  -0.5f, 1, -0.5f, 1, 0, 0, 0, 0, 1 };
    rsm_texel light;
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    float p[6] = { 0, 1, 0, 0, 3, 0 }, n[6] = { 0, -1, 0, 0, -1, 0 }, e[6];
    rsm_points points = points_of(p, n, 2, 0);
    model m = model_quads(quads, 2);
    rsm_mesh mesh = mesh_of(&m, 0.5);
    rsm_desc d = sun_desc(1, 1.5, 256);
    rsm_direct_desc direct = rsm_direct_default();
    rsm_map *map = map_of(&d, &mesh, 1, NULL);
    (void)state;
    memset(&light, 0, sizeof light);
    set3(light.normal, 0, 1, 0);
    set3(light.flux, PI, PI, PI);
    assert_int_equal(rsm_gather_list(&light, 1, &g, &points, e, NULL), RSM_OK);
    CONFORM("T29", "irradiance of flux pi straight above, distance 1", 1, e[0], 1e-6);
    CONFORM("T29", "the same at distance 3", 1.0 / 9, e[3], 1e-7);
    assert_non_null(map);
    p[1] = 0;
    p[3] = 0.9f;
    p[4] = 0;
    n[1] = n[4] = 1;
    assert_int_equal(rsm_direct(map, &direct, &points, e), RSM_OK);
    CONFORM("T29", "direct light under a full blocker", 0, e[0], 0);
    CONFORM("T29", "direct light beside it", 1, e[3], 1e-6);
    rsm_map_free(map);
    model_free(&m);
}

static void outside_is_dark(void **state)
{
    model m = model_disc(1024, 1);
    rsm_mesh mesh = mesh_of(&m, 0.5);
    rsm_desc d = sun_desc(2, 1.25, 512);
    rsm_map *map;
    int p;
    (void)state;
    d.light.position[0] = 1.25f;                 /* the map's border runs through the centre of the disc */
    map = map_of(&d, &mesh, 1, NULL);
    assert_non_null(map);
    for (p = RSM_PATTERN_FLUX; p < RSM_PATTERN_COUNT; p++) {
        rsm_gather_desc g = gather_desc((rsm_pattern)p, 4000);
        CONFORM("T36", ROW("half the disc is lit / (rho E0)", p), 0.25, mean_above(map, g, 1, 8), 0.004);
        g.r_max = 0.5f;
        if (p != RSM_PATTERN_FLUX && p != RSM_PATTERN_MIXED)
            CONFORM("T36", ROW("the same, pattern across the border", p), 0.25, mean_above(map, g, 1, 8), 0.006);
    }
    rsm_map_free(map);
    model_free(&m);
}

static void backward_shift(void **state)
{
    rsm_map *map = disc_map(1, 256);
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    double e0 = above(map, &g, 1), s;
    (void)state;
    CONFORM("T38", "irradiance without shift / (rho E0)", 0.5, e0, 1e-3);
    for (s = 0.05; s < 0.3; s *= 2) {
        char what[80];
        g.offset = (float)s;
        snprintf(what, sizeof what, "relative change for a shift of %g at distance 1", s);
        /* the disc of T25 seen from 1 + s: exact */
        CONFORM("T38", what, 2 / (1 + (1 + s) * (1 + s)) - 1, above(map, &g, 1) / e0 - 1, 1e-3);
    }
    rsm_map_free(map);
}

static void no_light_of_its_own(void **state)
{
    static const double normals[3][3] = { { 0, 1, 0 }, { 0.6, 0.8, 0 }, { 0.48, 0.6, 0.64 } };
    double most = 0;
    int k, p, i;
    (void)state;
    for (k = 0; k < 3; k++) {
        const double *n = normals[k];
        float q[9], x[3 * 64], nn[3 * 64], e[3 * 64];
        model m;
        rsm_mesh mesh;
        rsm_desc d = sun_desc(1, 4, 256);
        rsm_map *map;
        rsm_points points = points_of(x, nn, 64, 8);
        double u[3] = { n[1], -n[0], 0 }, v[3], length = hypot(u[0], u[1]);
        for (i = 0; i < 3; i++) u[i] /= length;
        v[0] = n[1] * u[2] - n[2] * u[1];
        v[1] = n[2] * u[0] - n[0] * u[2];
        v[2] = n[0] * u[1] - n[1] * u[0];
        for (i = 0; i < 3; i++) {
            q[i] = (float)(0.3 - 50 * u[i] - 50 * v[i]);
            q[3 + i] = (float)(100 * u[i]);
            q[6 + i] = (float)(100 * v[i]);
        }
        for (i = 0; i < 64; i++) {
            double s = 0.1 * (i % 8), t = 0.13 * (i / 8);
            set3(x + 3 * i, 0.3 + s * u[0] + t * v[0], 0.3 + s * u[1] + t * v[1], 0.3 + s * u[2] + t * v[2]);
            set3(nn + 3 * i, n[0], n[1], n[2]);
        }
        m = model_quads(q, 1);
        mesh = mesh_of(&m, 1);
        map = map_of(&d, &mesh, 1, NULL);
        assert_non_null(map);
        for (p = RSM_PATTERN_FLUX - 1; p < RSM_PATTERN_COUNT; p++) {
            rsm_gather_desc g = gather_desc((rsm_pattern)p, p < RSM_PATTERN_FLUX ? 0 : 500);
            assert_int_equal(rsm_gather((const rsm_map *const *)&map, 1, &g, &points, e, NULL), RSM_OK);
            for (i = 0; i < 3 * 64; i++) most = (double)e[i] > most ? (double)e[i] : most;
        }
        rsm_map_free(map);
        model_free(&m);
    }
    CONFORM("T40", "most light of three endless planes on themselves, every pattern", 0, most, 0);
}

/* Plane of pixel lights of radiance L under a receiver, kernel clamped: what is lost has a closed form. */
static void clamp_is_reported(void **state)
{
    enum { SIDE = 401 };
    static rsm_texel lights[SIDE * SIDE];
    const double h = 0.1, c = 25, spacing = 0.01;
    float p[3] = { 0, (float)h, 0 }, n[3] = { 0, -1, 0 }, full[3], e[3];
    rsm_points points = points_of(p, n, 1, 0);
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    rsm_gather_stats stats;
    int i;
    (void)state;
    for (i = 0; i < SIDE * SIDE; i++) {
        memset(&lights[i], 0, sizeof lights[i]);
        set3(lights[i].position, (i % SIDE - SIDE / 2) * spacing, 0, (i / SIDE - SIDE / 2) * spacing);
        set3(lights[i].normal, 0, 1, 0);
        set3(lights[i].flux, PI * spacing * spacing, PI * spacing * spacing, PI * spacing * spacing);
        lights[i].area = (float)(spacing * spacing);
    }
    assert_int_equal(rsm_gather_list(lights, SIDE * SIDE, &g, &points, full, NULL), RSM_OK);
    g.clamp = (float)c;
    assert_int_equal(rsm_gather_list(lights, SIDE * SIDE, &g, &points, e, &stats), RSM_OK);
    /* a square of 4 x 4 about a height of 0.1 stands for the plane to 0.3 %; points a tenth of h apart to 1e-3 */
    CONFORM("T44", "lost irradiance / (pi L), kernel clamped at 25, h = 0.1", 0.25, (double)(full[0] - e[0]) / PI,
            2e-3);
    CONFORM("T44", "the share that the library reports", (double)(full[0] - e[0]) / (double)full[0],
            stats.clamped_share, 1e-4);
}

/* ---- T39: a step and a crease, seen by a camera that looks down ---- */

enum { WIDE = 160, HIGH = 96 };

static float px[3 * WIDE * HIGH], pn[3 * WIDE * HIGH], full_e[3 * WIDE * HIGH], some_e[3 * WIDE * HIGH];
static uint8_t mask[WIDE * HIGH];

enum { STEP, CREASE, FLOOR };

/* Floor and a step half a unit up; two slopes that meet; floor alone. */
static void look_down(int shape)
{
    int x, y;
    for (y = 0; y < HIGH; y++)
        for (x = 0; x < WIDE; x++) {
            double u = (x + 0.5) / WIDE * 4 - 2, v = (y + 0.5) / HIGH * 2.4 - 1.2, s = u + 0.2 * v;
            float *p = px + 3 * (y * WIDE + x), *n = pn + 3 * (y * WIDE + x);
            if (shape == CREASE) {
                double l = sqrt(1.0 + 0.36 * 1.04);
                set3(p, u, 0.6 * fabs(s), v);
                set3(n, (s > 0 ? -0.6 : 0.6) / l, 1 / l, (s > 0 ? -0.12 : 0.12) / l);
            } else {
                set3(p, u, shape == STEP && s > 0.3 ? 0.5 : 0, v);
                set3(n, 0, 1, 0);
            }
        }
}

/* What the sun lights: one quad, seen from (x, y, z). */
static rsm_map *lit_quad(const float *quad, double x, double y, double z)
{
    model m = model_quads(quad, 1);
    rsm_mesh mesh = mesh_of(&m, 0.8);
    rsm_desc d = sun_desc(3, 4, 256);
    rsm_map *map;
    set3(d.light.direction, x, y, z);
    map = map_of(&d, &mesh, 1, NULL);
    assert_non_null(map);
    model_free(&m);
    return map;
}

/* A wall beside the scene. */
static rsm_map *lit_wall(void)
{
    static const float wall[] = { -2.5f, 0, -3, 0, 0, 6, 0, 3, 0 };
    return lit_quad(wall, 0.8, 0.6, 0);
}

static void interpolation_stops_at_edges(void **state)
{
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 400);
    rsm_points points = points_of(px, pn, WIDE * HIGH, WIDE);
    rsm_map *map = lit_wall();
    int crease, paper;
    (void)state;
    for (crease = 0; crease < 2; crease++)
        for (paper = 0; paper < 2; paper++) {
            rsm_interpolation in;
            rsm_gather_stats stats;
            double worst = 0, mean = 0;
            char what[100];
            int i, marked = 0;
            look_down(crease ? CREASE : STEP);
            memset(&in, 0, sizeof in);
            in.mask = mask;
            in.levels = paper ? 1 : 0;
            in.contrast = paper ? -1.0f : 0.0f;
            in.reach = paper ? -1.0f : 0.0f;
            assert_int_equal(rsm_gather((const rsm_map *const *)&map, 1, &g, &points, full_e, NULL), RSM_OK);
            assert_int_equal(rsm_interpolate((const rsm_map *const *)&map, 1, &g, &in, &points, some_e, &stats),
                             RSM_OK);
            for (i = 0; i < WIDE * HIGH; i++) {
                double off = fabs((double)full_e[3 * i] - (double)some_e[3 * i]);
                worst = off > worst ? off : worst;
                mean += (double)full_e[3 * i] / (WIDE * HIGH);
                marked += mask[i] == 2;
                assert_true(mask[i] == 1 || mask[i] == 2);
            }
            assert_int_equal(marked, stats.evaluated);
            snprintf(what, sizeof what, "largest error / mean, %s, %s", crease ? "crease" : "step",
                     paper ? "one grid of 8 (paper)" : "grids of 8, 4, 2");
            /* contrast and reach bound the one; curvature over 8 pixels at the wall's foot is what the other leaves */
            CONFORM_MAX("T39", what, paper ? 0.08 : 0.05, worst / mean);
            snprintf(what, sizeof what, "share evaluated, %s, %s", crease ? "crease" : "step",
                     paper ? "one grid of 8 (paper)" : "grids of 8, 4, 2");
            CONFORM_MAX("T39", what, 0.3, (double)stats.evaluated / (WIDE * HIGH));
        }
    rsm_map_free(map);
}

/* A light of 0.05 x 0.05 hangs 0.06 over the floor, midway between the samples of the grid (0.2 apart): the four next to it
   agree, so that contrast finds nothing between them. */
static void reach_refines(void **state)
{
    static const float lamp[] = { 0.0875f, 0.06f, 0.0875f, 0.05f, 0, 0, 0, 0, 0.05f };
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 400);
    rsm_points points = points_of(px, pn, WIDE * HIGH, WIDE);
    rsm_map *map = lit_quad(lamp, 0, -1, 0);
    const size_t under = 3 * (52 * WIDE + 84);
    double error[2];
    int bounded, i;
    (void)state;
    look_down(FLOOR);
    assert_int_equal(rsm_gather((const rsm_map *const *)&map, 1, &g, &points, full_e, NULL), RSM_OK);
    for (bounded = 0; bounded < 2; bounded++) {
        rsm_interpolation in;
        double square = 0, sum = 0;
        memset(&in, 0, sizeof in);
        in.mask = mask;
        in.reach = bounded ? 0.0f : -1.0f;
        assert_int_equal(rsm_interpolate((const rsm_map *const *)&map, 1, &g, &in, &points, some_e, NULL), RSM_OK);
        for (i = 0; i < 3 * WIDE * HIGH; i++) {
            double off = (double)full_e[i] - (double)some_e[i];
            square += off * off;
            sum += (double)full_e[i];
        }
        error[bounded] = sqrt(square * 3 * WIDE * HIGH) / sum;
        if (bounded)
            CONFORM("T39", "light under a small lamp between samples / full", 1, some_e[under] / full_e[under], 0.01);
        else
            assert_true((double)some_e[under] < 0.5 * (double)full_e[under] && mask[under / 3] == 1);
    }
    CONFORM_MAX("T39", "relative RMSE, small lamp between samples", 0.02, error[1]);
    assert_true(error[1] < 0.1 * error[0]);
    rsm_map_free(map);
}

/* Filter: interleaved sets and two passes give the mean of all sets; frames pile up; edges keep their sides. */
static void filter_puts_sets_together(void **state)
{
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 416);
    rsm_points points = points_of(px, pn, WIDE * HIGH, WIDE);
    rsm_filter_desc f;
    rsm_filter *filter;
    rsm_map *map = lit_wall();
    double error = 0, raw = 0, mean = 0;
    int i;
    (void)state;
    look_down(STEP);
    assert_int_equal(rsm_gather((const rsm_map *const *)&map, 1, &g, &points, full_e, NULL), RSM_OK);
    g.interleave = 4;
    assert_int_equal(rsm_gather((const rsm_map *const *)&map, 1, &g, &points, some_e, NULL), RSM_OK);
    for (i = 0; i < WIDE * HIGH; i++) raw += pow((double)full_e[3 * i] - (double)some_e[3 * i], 2) / (WIDE * HIGH);
    memset(&f, 0, sizeof f);
    f.passes = 2;
    assert_int_equal(rsm_filter_create(WIDE, HIGH, NULL, &filter), RSM_OK);
    assert_int_equal(rsm_filter_apply(filter, &f, &points, some_e, some_e), RSM_OK);
    for (i = 0; i < WIDE * HIGH; i++) {
        error += pow((double)full_e[3 * i] - (double)some_e[3 * i], 2) / (WIDE * HIGH);
        mean += (double)full_e[3 * i] / (WIDE * HIGH);
    }
    if (!(sqrt(error) < 0.025 * mean && sqrt(error) < 0.1 * sqrt(raw)))
        fail_msg("4 x 4 sets filtered: relative error %g, unfiltered %g", sqrt(error) / mean, sqrt(raw) / mean);
    rsm_filter_free(filter);
    rsm_map_free(map);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_over_pi),      cmocka_unit_test(weights),           cmocka_unit_test(normalised),
        cmocka_unit_test(scale_cancels),    cmocka_unit_test(falloff),           cmocka_unit_test(outside_is_dark),
        cmocka_unit_test(backward_shift),   cmocka_unit_test(no_light_of_its_own), cmocka_unit_test(clamp_is_reported),
        cmocka_unit_test(interpolation_stops_at_edges), cmocka_unit_test(reach_refines),
        cmocka_unit_test(filter_puts_sets_together),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
