/* gather_rows_test - maps and bounced light of rsm.h against closed forms: the rows of rsm/rows.h, and those that only
   the CPU computes (T26, T27 and T44 of docs/conformance.md). */

#include "rsm.h"
#include "gifilter.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>
#include "conformance.h"
#include "util.h"

#define ROW_TEST(state) (void)(state);
#define ROW_POISSONS 8
#include "rows.h"

/* ---- the rows by rsm.h ---- */

struct lit { rsm_map *map; const rsm_texel *list; size_t count; double flux; };

static lit *lit_of(const rsm_desc *desc, const rsm_mesh *meshes, size_t count)
{
    lit *l = (lit *)calloc(1, sizeof *l);
    rsm_stats stats;
    assert_non_null(l);
    l->map = map_of(desc, meshes, count, &stats);
    assert_non_null(l->map);
    assert_int_equal(stats.bad_texels, 0);
    if (meshes[0].albedo[0] >= 1) assert_true(fabs(stats.incident[0] - stats.reflected[0]) <= 1e-5 * stats.incident[0]);
    l->flux = stats.reflected[0];
    return l;
}

static lit *lit_list(const rsm_texel *lights, uint32_t side)
{
    lit *l = (lit *)calloc(1, sizeof *l);
    assert_non_null(l);
    l->list = lights;
    l->count = (size_t)side * side;
    return l;
}

static void lit_free(lit *l)
{
    rsm_map_free(l->map);
    free(l);
}

static double lit_flux(lit *l) { return l->flux; }

static void lit_places(lit *l, uint32_t samples, float *p)
{
    rsm_texel *lights = (rsm_texel *)malloc(samples * sizeof *lights);
    size_t count, i;
    assert_non_null(lights);
    assert_int_equal(rsm_pixel_lights((const rsm_map *const *)&l->map, 1, samples, 3, lights, samples, &count), RSM_OK);
    assert_int_equal(count, samples);
    for (i = 0; i < samples; i++) memcpy(p + 3 * i, lights[i].position, 12);
    free(lights);
}

static void lit_gather(lit *l, const rsm_gather_desc *g, const rsm_points *points, float *e)
{
    if (l->map) assert_int_equal(rsm_gather((const rsm_map *const *)&l->map, 1, g, points, e, NULL), RSM_OK);
    else assert_int_equal(rsm_gather_list(l->list, l->count, g, points, e, NULL), RSM_OK);
}

static void lit_direct(lit *l, const rsm_points *points, float *e)
{
    rsm_direct_desc d = direct_desc();
    assert_int_equal(rsm_direct(l->map, &d, points, e), RSM_OK);
}

static double lit_interpolate(lit *l, const rsm_gather_desc *g, const rsm_interpolation *in,
                              const rsm_points *points, float *e)
{
    rsm_gather_stats stats;
    size_t i, marked = 0;
    assert_int_equal(rsm_interpolate((const rsm_map *const *)&l->map, 1, g, in, points, e, &stats), RSM_OK);
    for (i = 0; i < points->count; i++) marked += in->mask[i] == 2;
    assert_int_equal(marked, stats.evaluated);
    return (double)marked / (double)points->count;
}

/* ---- what only the CPU computes: patterns and statistics ---- */

static void weights_give_the_inner_half_its_share(void **state)
{
    static float pattern[3 * 4096];
    char text[100];
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
            else CONFORM("T26", with_pattern(text, "indicator of the inner half radius", p), 0.25, inner, 0.004);
        }                                        /* 4096 points */
}

/* LOG_RADIAL: C / r^2 from r_min out and C / r_min^2 inside it, so that 1 / (1 + 2 ln(1 / r_min)) of the samples lie
   there, for r_min^2 of the disc. A gather takes its own r_min: another choice, the same light. */
static void r_min_is_the_inner_disc(void **state)
{
    static const float radii[] = { 0, 1.0f / 32, 0.25f };
    static float pattern[3 * 4096];
    rsm_gather_desc g = gather_desc(RSM_PATTERN_LOG_RADIAL, 4096);
    const float at[3] = { -1, 1, 0.2f }, n[3] = { -1, 0, 0 };
    rsm_points points = points_of(at, n, 1, 0);
    lit *map = lit_wall();
    float e[3][3], all[3];
    int i, k;
    (void)state;
    for (k = 0; k < 3; k++) {
        double r = k == 2 ? 0.25 : 1.0 / 32, inside = 0, weight = 0;
        assert_int_equal(rsm_pattern_build(RSM_PATTERN_LOG_RADIAL, 4096, radii[k], 0, 1, pattern), RSM_OK);
        for (i = 0; i < 4096; i++) {
            if (!(hypot((double)pattern[3 * i], (double)pattern[3 * i + 1]) < r * 0.999999)) continue;
            inside += 1.0 / 4096;
            weight += (double)pattern[3 * i + 2] / PI;
        }
        assert_true(fabs(inside - 1 / (1 - 2 * log(r))) < 2.0 / 4096);      /* whole samples */
        assert_true(fabs(weight / (r * r) - 1) < 0.01);
        g.r_min = radii[k];
        g.r_max = 2;
        lit_gather(map, &g, &points, e[k]);
    }
    g.pattern = RSM_PATTERN_FLUX;
    g.sample_count = 0;
    lit_gather(map, &g, &points, all);
    assert_memory_equal(e[0], e[1], sizeof e[0]);
    assert_true(memcmp(e[0], e[2], sizeof e[0]) != 0);
    for (k = 0; k < 3; k++)                     /* 4096 samples: 0.1 % off, measured */
        assert_true(fabs((double)e[k][0] / (double)all[0] - 1) < 0.005);
    lit_free(map);
}

/* Pixels are 0.025 apart: within 0.01 of a pixel lies no sample of any grid, so that all are evaluated; within 0.06
   those of the finer grids alone. */
static void distance_bounds_interpolation(void **state)
{
    static const float distances[] = { 0, 0.06f, 0.01f };
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 16);
    rsm_points points = points_of(px, pn, WIDE * HIGH, WIDE);
    lit *map = lit_wall();
    double share[3];
    int k;
    (void)state;
    look_down(FLOOR);
    lit_gather(map, &g, &points, full_e);
    for (k = 0; k < 3; k++) {
        rsm_interpolation in;
        memset(&in, 0, sizeof in);
        in.mask = mask;
        in.distance = distances[k];
        in.contrast = in.light_share = -1;
        share[k] = lit_interpolate(map, &g, &in, &points, some_e);
    }
    print_message("evaluated: %.4f, %.4f, %.4f\n", share[0], share[1], share[2]);
    assert_true(share[0] < 0.05 && share[1] > 0.06 && share[1] < 0.6 && share[2] >= 1);
    assert_memory_equal(full_e, some_e, sizeof full_e);
    lit_free(map);
}

/* A sun on a floor and a wall: receivers on the wall down to a texel above the floor, 400 samples by MIXED against
   every texel. Its dense samples must reach down to the size of texels, and be even for any number of them. */
static void the_mixed_pattern_reaches_into_a_corner(void **state)
{
    static const float quads[18] = { -1, 0, -1, 0, 0, 2, 2, 0, 0, -1, 0, -1, 0, 2, 0, 0, 0, 2 };
    enum { SEEDS = 4, POINTS = 200 };
    static float p[3 * POINTS], n[3 * POINTS], all[3 * POINTS], e[3 * POINTS];
    model m = model_quads(quads, 2);
    rsm_mesh mesh = mesh_of(&m, 0.5);
    rsm_desc d = sun_desc(1, 1.5, 512);
    rsm_points points = points_of(p, n, POINTS, 0);
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    double square = 0, sum = 0;
    lit *map;
    int i;
    (void)state;
    set3(d.light.direction, 0.6, 0.8, 0);
    map = lit_of(&d, &mesh, 1);
    for (i = 0; i < POINTS; i++) {
        set3(p + 3 * i, -1, 0.008 * pow(1.25, i % 20), -0.5 + 0.1 * (i / 20));
        set3(n + 3 * i, 1, 0, 0);
    }
    g.near_limit = 0.3f;
    lit_gather(map, &g, &points, all);
    g.pattern = RSM_PATTERN_MIXED;
    g.sample_count = 400;
    for (g.seed = 0; g.seed < SEEDS; g.seed++) {
        lit_gather(map, &g, &points, e);
        for (i = 0; i < POINTS; i++) {
            square += pow((double)e[3 * i] - (double)all[3 * i], 2);
            sum += (double)all[3 * i];
        }
    }
    if (!(sqrt(square * SEEDS * POINTS) < 0.03 * sum))
        fail_msg("relative error %g", sqrt(square * SEEDS * POINTS) / sum);
    lit_free(map);
    model_free(&m);
}

static void shares_are_reported(void **state)
{
    lit *map = disc_map(1, 512, 0);
    rsm_gather_desc g = gather_desc(RSM_PATTERN_EQUATION3, 8192);
    rsm_gather_stats stats;
    float p[3] = { 0, 1, 0 }, n[3] = { 0, -1, 0 }, full[3], e[3];
    rsm_points points = points_of(p, n, 1, 0);
    (void)state;
    g.r_max = 0.2f;                              /* half the disc's radius: a quarter of its flux remains */
    assert_int_equal(rsm_gather((const rsm_map *const *)&map->map, 1, &g, &points, e, &stats), RSM_OK);
    CONFORM("T27", "share of the flux beyond r_max = half the disc, as reported", 0.75, stats.outside_share, 2e-3);
    lit_free(map);
    map = lit_list(plane_of_lights(), PLANE_SIDE);
    g = gather_desc(RSM_PATTERN_FLUX, 0);
    p[1] = 0.1f;
    lit_gather(map, &g, &points, full);
    g.clamp = 25;
    assert_int_equal(rsm_gather_list(map->list, map->count, &g, &points, e, &stats), RSM_OK);
    CONFORM("T44", "the share that the library reports", (double)(full[0] - e[0]) / (double)full[0],
            stats.clamped_share, 1e-4);
    lit_free(map);
}

/* Interpolated or not, the shares are the same where all receivers are. */
static void interpolated_receivers_have_the_shares_of_all(void **state)
{
    enum { N = 9 };
    lit *map = disc_map(1, 512, 0);
    rsm_gather_desc g = gather_desc(RSM_PATTERN_EQUATION3, 1024);
    rsm_gather_stats one, all;
    rsm_interpolation how;
    float p[3 * N * N], n[3 * N * N], e[3 * N * N];
    rsm_points points = points_of(p, n, N * N, N);
    int i;
    (void)state;
    memset(&how, 0, sizeof how);
    how.step = 4;
    for (i = 0; i < N * N; i++) {
        set3(p + 3 * i, 0, 1, 0);
        set3(n + 3 * i, 0, -1, 0);
    }
    g.r_max = 0.2f;
    g.clamp = 0.9f;
    points.count = 1;
    assert_int_equal(rsm_gather((const rsm_map *const *)&map->map, 1, &g, &points, e, &one), RSM_OK);
    points.count = N * N;
    assert_int_equal(rsm_interpolate((const rsm_map *const *)&map->map, 1, &g, &how, &points, e, &all), RSM_OK);
    assert_true(all.evaluated >= 4 && all.evaluated < N * N);
    assert_true(one.outside_share > 0.7 && fabs(all.outside_share - one.outside_share) < 2e-3);
    assert_true(one.clamped_share > 0.01 && fabs(all.clamped_share - one.clamped_share) < 5e-3);
    lit_free(map);
}

/* Interleaved sets and two passes of gifilter.h give the mean of all sets. */
static void filter_puts_sets_together(void **state)
{
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 416);
    rsm_points points = points_of(px, pn, WIDE * HIGH, WIDE);
    gifilt_points pixels;
    gifilt_frame f;
    gifilt_desc size;
    gifilt_filter *filter;
    lit *map = lit_wall();
    double error = 0, raw = 0, mean = 0;
    int i;
    (void)state;
    look_down(STEP);
    lit_gather(map, &g, &points, full_e);
    g.interleave = 4;
    lit_gather(map, &g, &points, some_e);
    for (i = 0; i < WIDE * HIGH; i++) raw += pow((double)full_e[3 * i] - (double)some_e[3 * i], 2) / (WIDE * HIGH);
    memset(&pixels, 0, sizeof pixels);
    pixels.count = WIDE * HIGH;
    pixels.positions = px;
    pixels.normals = pn;
    memset(&f, 0, sizeof f);
    f.passes = 2;
    memset(&size, 0, sizeof size);
    size.width = WIDE;
    size.height = HIGH;
    assert_int_equal(gifilt_create(&size, &filter), GIFILT_OK);
    assert_int_equal(gifilt_apply(filter, &f, &pixels, some_e, some_e), GIFILT_OK);
    for (i = 0; i < WIDE * HIGH; i++) {
        error += pow((double)full_e[3 * i] - (double)some_e[3 * i], 2) / (WIDE * HIGH);
        mean += (double)full_e[3 * i] / (WIDE * HIGH);
    }
    if (!(sqrt(error) < 0.025 * mean && sqrt(error) < 0.1 * sqrt(raw)))
        fail_msg("4 x 4 sets filtered: relative error %g, unfiltered %g", sqrt(error) / mean, sqrt(raw) / mean);
    gifilt_free(filter);
    lit_free(map);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        RSM_ROWS(cmocka_unit_test), cmocka_unit_test(weights_give_the_inner_half_its_share),
        cmocka_unit_test(shares_are_reported),
        cmocka_unit_test(interpolated_receivers_have_the_shares_of_all),
        cmocka_unit_test(the_mixed_pattern_reaches_into_a_corner), cmocka_unit_test(r_min_is_the_inner_disc),
        cmocka_unit_test(distance_bounds_interpolation),
        cmocka_unit_test(filter_puts_sets_together),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
