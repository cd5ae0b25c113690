/* lights_rows_test - rows T11 to T13 and T15 to T22: weights of texels, energy, seams, bad texels; jitter, follow,
   residual, export. */

#define ENVLT_STATIC
#define ENVLIGHTS_IMPLEMENTATION
#include "envlights.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "conformance.h"
#include "util.h"

static const envlt_method methods[] = { ENVLT_METHOD_STRUCTURED, ENVLT_METHOD_MEDIAN_CUT, ENVLT_METHOD_VARIANCE,
                                        ENVLT_METHOD_CDF };
#define METHODS 4

static envlt_lights *build(const envlt_desc *desc, const envlt_map *map, envlt_stats *stats)
{
    envlt_lights *l = NULL;
    assert_int_equal(envlt_create(desc, map, &l, stats), ENVLT_OK);
    assert_non_null(l);
    return l;
}

static void exact_energy(const sky *s, double *rgb)
{
    size_t t;
    int c;
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (t = 0; t < s->texels; t++) {
        double d[3], omega;
        sky_texel(s, t, d, &omega);
        for (c = 0; c < 3; c++) rgb[c] += omega * (double)s->rgb[3 * t + (size_t)c];
    }
}

static void light_energy(const envlt_lights *l, double *rgb)
{
    uint32_t count, i;
    const envlt_light *list = envlt_get_lights(l, &count);
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (i = 0; i < count; i++)
        for (int c = 0; c < 3; c++) rgb[c] += (double)list[i].irradiance[c];
}

/* ---- T11 to T13 ---- */

static void cap(const double *d, double *rgb)
{
    rgb[0] = rgb[1] = rgb[2] = d[1] > cos(PI / 6) ? 1 : 0;
}

static void latitude_is_weighted(void **state)
{
    sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 96, 48), all = sky_alloc(ENVLT_PROJECTION_LATLONG, 96, 48);
    double rgb[3], whole[3];
    (void)state;
    sky_fill(&s, cap);          /* 30 degrees are 8 rows: the cap ends on a texel's edge */
    sky_fill(&all, even);
    for (int m = 0; m < METHODS; m++) {
        envlt_desc d = desc_of(methods[m], 20);
        envlt_lights *a = build(&d, &s.map, NULL), *b = build(&d, &all.map, NULL);
        light_energy(a, rgb);
        light_energy(b, whole);
        /* floats of 1e-7 each, summed in double */
        if (m == 0) CONFORM("T11", "share of a cap of 30 degrees in the lights", 0.0669872981, rgb[0] / whole[0], 1e-6);
        else CLOSE(rgb[0] / whole[0], 0.0669872981, 1e-6);
        envlt_free(a);
        envlt_free(b);
    }
    sky_free(&s);
    sky_free(&all);
}

static double total_omega(envlt_projection p, uint32_t w, uint32_t h, uint32_t faces)
{
    double sum = 0;
    for (uint32_t y = 0; y < h; y++) {              /* by rows: 2e4 terms in one sum would round by 1e-12 themselves */
        double row = 0;
        for (uint32_t x = 0; x < w; x++) row += envlt_texel_solid_angle(p, w, h, x, y);
        sum += row;
    }
    return sum * faces;
}

static void solid_angles_are_exact(void **state)
{
    double worst = 0, direct = 0;
    (void)state;
    for (uint32_t h = 1; h < 200; h = 2 * h + 1)
        worst = fmax(worst, fabs(total_omega(ENVLT_PROJECTION_LATLONG, 2 * h, h, 1) - 4 * PI));
    CONFORM_MAX("T12", "solid angle of a latitude-longitude map, off 4 pi", 1e-12, worst);
    for (uint32_t y = 0; y < 64; y++)               /* a row by row check: the sum alone would hide a wrong cosine */
        direct = fmax(direct, fabs(envlt_texel_solid_angle(ENVLT_PROJECTION_LATLONG, 128, 64, 0, y) -
                                   2 * PI / 128 * (cos(PI * y / 64) - cos(PI * (y + 1) / 64))));
    CONFORM_MAX("T12", "solid angle of a texel, off difference of cosines", 1e-15, direct);
    worst = 0;
    for (uint32_t n = 1; n < 130; n = 2 * n + 1)
        worst = fmax(worst, fabs(total_omega(ENVLT_PROJECTION_CUBE, n, n, 6) - 4 * PI));
    CONFORM_MAX("T13", "solid angle of a cube, off 4 pi", 1e-12, worst);
    CONFORM("T13", "solid angle of a cube's face", 2 * PI / 3, total_omega(ENVLT_PROJECTION_CUBE, 33, 33, 1), 1e-12);
    /* at side 1023 a corner texel is off the limit 3^-3/2 by 1 / side */
    CONFORM("T13", "corner texel over centre texel", 0.19245009,
            envlt_texel_solid_angle(ENVLT_PROJECTION_CUBE, 1023, 1023, 0, 0) /
            envlt_texel_solid_angle(ENVLT_PROJECTION_CUBE, 1023, 1023, 511, 511), 0.19245009 * 2.1 / 1023);
}

/* ---- T15 ---- */

static void no_light_comes_from_an_empty_texel(void **state)
{
    sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 2, 1);
    (void)state;
    s.rgb[3] = s.rgb[4] = s.rgb[5] = 1;             /* u above a half: z < 0 has none of it */
    for (int m = 0; m < METHODS; m++) {
        envlt_desc d = desc_of(methods[m], 4);
        envlt_lights *l = build(&d, &s.map, NULL);
        envlt_light one[4];
        uint32_t count;
        envlt_get_lights(l, &count);
        assert_int_equal(count, 1);
        for (uint32_t frame = 0; frame < 4096; frame++) {
            assert_int_equal(envlt_jitter(l, frame, 5, one), ENVLT_OK);
            assert_true(one[0].direction[2] > -1e-6f);
        }
        envlt_free(l);
    }
    sky_free(&s);
}

/* The sampler itself at its ends; then a chi-square test of jittered directions. */
static void inversion_keeps_in_range(void **state)
{
    static const double sums[5] = { 0, 0, 1, 4, 4 };        /* of the weights 0 1 3 0 */
    envlt__cdf cdf = { sums, 4 };
    (void)state;
    assert_int_equal(envlt__cdf_sample_at(&cdf, 0).index, 1);
    assert_int_equal(envlt__cdf_sample_at(&cdf, 1 - 1.0f / 16777216).index, 2);
    assert_int_equal(envlt__cdf_sample_at(&cdf, 0.2499f).index, 1);
    assert_int_equal(envlt__cdf_sample_at(&cdf, 0.2501f).index, 2);
}

static void jitter_is_in_proportion(void **state)
{
    enum { W = 64, H = 32, DRAWS = 200000 };
    sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, W, H);
    envlt_desc d = desc_of(ENVLT_METHOD_MEDIAN_CUT, 1);
    static uint32_t hits[W * H];
    uint64_t seed = 11;
    double total = 0, chi = 0;
    envlt_lights *l;
    int cells = 0;
    (void)state;
    for (size_t t = 0; t < s.texels; t++)
        s.rgb[3 * t] = s.rgb[3 * t + 1] = s.rgb[3 * t + 2] = (float)(rnd(&seed) < 0.2 ? 0 : rnd(&seed));
    l = build(&d, &s.map, NULL);
    memset(hits, 0, sizeof hits);
    for (uint32_t i = 0; i < DRAWS; i++) {
        envlt_light one;
        double u, v;
        assert_int_equal(envlt_jitter(l, i % 256, i / 256, &one), ENVLT_OK);
        u = 0.5 + atan2((double)one.direction[2], (double)one.direction[0]) / (2 * PI);
        v = acos((double)one.direction[1]) / PI;
        hits[(size_t)fmin(v * H, H - 1) * W + (size_t)fmin(u * W, W - 1)]++;
    }
    for (size_t t = 0; t < s.texels; t++)
        total += (double)s.rgb[3 * t] * envlt_texel_solid_angle(ENVLT_PROJECTION_LATLONG, W, H, 0, (uint32_t)(t / W));
    for (size_t t = 0; t < s.texels; t++) {
        double e = DRAWS / total * (double)s.rgb[3 * t];
        e *= envlt_texel_solid_angle(ENVLT_PROJECTION_LATLONG, W, H, 0, (uint32_t)(t / W));
        if (e < 5) {
            /* rounding of the direction may cross a texel's edge, never further */
            if (!(e > 0)) assert_true(hits[t] <= 5);
            continue;
        }
        chi += (hits[t] - e) * (hits[t] - e) / e;
        cells++;
    }
    /* p > 0.001: the normal approximation of chi-square, 3.09 sigma */
    CONFORM_MAX("T15", "chi-square of jittered directions over cells, above its mean in sigma", 3.09,
                (chi - cells) / sqrt(2.0 * cells));
    envlt_free(l);
    sky_free(&s);
}

/* ---- T16 to T19 ---- */

static void red_ramp(const double *d, double *rgb)
{
    rgb[0] = 1 + d[0];
    rgb[1] = rgb[2] = 0;
}

static void red_stays_red(void **state)
{
    (void)state;
    for (int m = 0; m < METHODS; m++) {
        sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 64, 32);
        envlt_desc d = desc_of(methods[m], 32);
        envlt_lights *l;
        uint32_t count;
        const envlt_light *list;
        sky_fill(&s, red_ramp);
        l = build(&d, &s.map, NULL);
        list = envlt_get_lights(l, &count);
        assert_in_range(count, 24, 32);
        for (uint32_t i = 0; i < count; i++)
            assert_true(list[i].irradiance[0] > 0 && list[i].irradiance[1] <= 0 && list[i].irradiance[2] <= 0);
        if (m == 0)
            CONFORM_MAX("T18", "green and blue in the lights of a red map", 0,
                        (double)(list[0].irradiance[1] + list[0].irradiance[2]));
        envlt_free(l);
        sky_free(&s);
    }
}

/* Every texel belongs to one light, and each light has what its texels have. */
static double strata_error(const sky *s, const envlt_lights *l)
{
    uint32_t count;
    const envlt_light *list = envlt_get_lights(l, &count);
    size_t texels;
    const uint32_t *strata = envlt_strata(l, &texels);
    static double sums[1024][4];
    double worst = 0, total = 0;
    assert_int_equal(texels, s->texels);
    memset(sums, 0, sizeof sums);
    for (size_t t = 0; t < texels; t++) {
        double d[3], omega;
        assert_true(strata[t] < count);
        sky_texel(s, t, d, &omega);
        for (size_t c = 0; c < 3; c++) sums[strata[t]][c] += omega * (double)s->rgb[3 * t + c];
        sums[strata[t]][3] += omega;
        total += omega;
    }
    for (uint32_t i = 0; i < count; i++) {
        for (int c = 0; c < 3; c++)
            worst = fmax(worst, fabs((double)list[i].irradiance[c] - sums[i][c]) / (sums[i][c] + 1e-6));
        worst = fmax(worst, fabs((double)list[i].solid_angle - sums[i][3]) / sums[i][3]);
    }
    CLOSE(total, 4 * PI, 1e-9);
    return worst;
}

static void energy_is_exact(void **state)
{
    static const uint32_t counts[] = { 1, 2, 3, 5, 6, 7, 16, 61, 128, 300 };
    double worst = 0, apart = 0;
    (void)state;
    for (int kind = 0; kind < 4; kind++) {
        sky s = kind & 1 ? sky_alloc(ENVLT_PROJECTION_CUBE, 24, 24) : sky_alloc(ENVLT_PROJECTION_LATLONG, 90, 45);
        double expected[3], found[3];
        sky_fill(&s, kind & 2 ? studio : sunny);
        exact_energy(&s, expected);
        for (int m = 0; m < METHODS; m++)
            for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
                envlt_desc d = desc_of(methods[m], counts[i]);
                envlt_stats stats;
                envlt_lights *l;
                d.split_sun = (int)(i & 1);
                l = build(&d, &s.map, &stats);
                light_energy(l, found);
                assert_in_range(stats.lights, 1, counts[i]);
                if (!(kind == 0 || m == 3)) assert_true(stats.lights >= counts[i] * 2 / 3);
                for (int c = 0; c < 3; c++) {
                    worst = fmax(worst, fabs(found[c] / expected[c] - 1));
                    worst = fmax(worst, fabs(stats.energy[c] / expected[c] - 1));
                }
                apart = fmax(apart, strata_error(&s, l));
                envlt_free(l);
            }
        sky_free(&s);
    }
    /* solid angles are kept in floats: 6e-8 each, less in the sum */
    CONFORM_MAX("T19", "sum of the lights off the integral, relative, any k and method", 1e-6, worst);
    CONFORM_MAX("T17", "a light off the sum over its texels, relative", 1e-6, apart);
    {
        sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 512, 256);
        envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, 128);
        envlt_lights *l;
        double found[3];
        sky_fill(&s, even);
        l = build(&d, &s.map, NULL);
        light_energy(l, found);
        CONFORM("T19", "sum of the lights of a constant map", 4 * PI, found[1], 4 * PI * 1e-6);
        envlt_free(l);
        sky_free(&s);
    }
}

/* A bright texel before two million dim ones: floats would lose the dim ones. */
static void sums_are_double(void **state)
{
    sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 2048, 1024);
    envlt_desc d = desc_of(ENVLT_METHOD_MEDIAN_CUT, 2);
    envlt_lights *l;
    double expected[3], found[3];
    (void)state;
    for (size_t t = 0; t < 3 * s.texels; t++) s.rgb[t] = 1e-5f;
    s.rgb[0] = s.rgb[1] = s.rgb[2] = 1e6f;
    exact_energy(&s, expected);
    l = build(&d, &s.map, NULL);
    light_energy(l, found);
    CONFORM("T16", "energy of a bright texel among two million dim ones", expected[0], found[0], expected[0] * 1e-6);
    envlt_free(l);
    sky_free(&s);
}

/* ---- T20, T21 ---- */

static void one_texel_is_one_light(void **state)
{
    (void)state;
    for (int cube = 0; cube < 2; cube++) {
        sky s = cube ? sky_alloc(ENVLT_PROJECTION_CUBE, 16, 16) : sky_alloc(ENVLT_PROJECTION_LATLONG, 40, 20);
        size_t at = cube ? 4 * 256 + 5 * 16 + 3 : 7 * 40 + 13;
        double d[3], omega, worst = 0;
        s.rgb[3 * at] = 3;
        s.rgb[3 * at + 1] = 2;
        sky_texel(&s, at, d, &omega);
        for (int m = 0; m < METHODS; m++) {
            envlt_desc desc = desc_of(methods[m], 50);
            envlt_lights *l = build(&desc, &s.map, NULL);
            uint32_t count;
            const envlt_light *list = envlt_get_lights(l, &count);
            assert_int_equal(count, 1);
            CLOSE(list[0].irradiance[0], 3 * omega, 3e-7 * omega);
            CLOSE(list[0].irradiance[1], 2 * omega, 3e-7 * omega);
            for (int c = 0; c < 3; c++) worst = fmax(worst, fabs((double)list[0].direction[c] - d[c]));
            envlt_free(l);
        }
        CONFORM_MAX("T20", cube ? "direction of a cube's only texel, off" : "direction of a map's only texel, off",
                    3e-7, worst);
        sky_free(&s);
    }
}

/* Ten degrees high, forty wide, round the seam at azimuth 180. */
static void seam_band(const double *d, double *rgb)
{
    double azimuth = atan2(d[2], d[0]);
    rgb[0] = rgb[1] = rgb[2] = 0.001 + 50 * (fabs(azimuth) > PI - 0.35 && fabs(d[1]) < 0.087);
}

static void seam_is_no_edge(void **state)
{
    double farthest = 0;
    (void)state;
    for (int m = 0; m < METHODS; m++) {
        sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 72, 36);
        uint32_t count, bright = 0;
        envlt_desc d = desc_of(methods[m], 12);
        envlt_lights *l;
        const envlt_light *list;
        sky_fill(&s, seam_band);
        l = build(&d, &s.map, NULL);
        list = envlt_get_lights(l, &count);
        for (uint32_t i = 0; i < count; i++) {
            if (list[i].irradiance[0] < 0.3f) continue;
            bright++;
            farthest = fmax(farthest, PI - fabs(atan2((double)list[i].direction[2], (double)list[i].direction[0])));
        }
        assert_in_range(bright, 1, 12);
        envlt_free(l);
        sky_free(&s);
    }
    CONFORM_MAX("T21", "lights of a band across the seam: radians from its middle", 0.35 + 2 * PI / 144, farthest);
}

/* Turns the map by some columns: how far its lights are off the turned lights of the map, in the same order. */
static double off_when_turned(const sky *a, const envlt_desc *d, uint32_t shift)
{
    const uint32_t w = a->map.width;
    sky b = sky_alloc(ENVLT_PROJECTION_LATLONG, w, a->map.height);
    envlt_lights *la, *lb;
    uint32_t na, nb;
    const envlt_light *ea, *eb;
    double angle = 2 * PI * shift / w, worst = 0;
    for (size_t t = 0; t < a->texels; t++)
        memcpy(b.rgb + 3 * (t / w * w + (t % w + shift) % w), a->rgb + 3 * t, 3 * sizeof(float));
    la = build(d, &a->map, NULL);
    lb = build(d, &b.map, NULL);
    ea = envlt_get_lights(la, &na);
    eb = envlt_get_lights(lb, &nb);
    assert_int_equal(na, nb);
    for (uint32_t i = 0; i < na; i++) {         /* azimuth + angle */
        const float *p = ea[i].direction, *q = eb[i].direction;
        double x = (double)p[0] * cos(angle) - (double)p[2] * sin(angle);
        double z = (double)p[0] * sin(angle) + (double)p[2] * cos(angle);
        worst = fmax(worst, fmax(fabs(x - (double)q[0]), fabs(z - (double)q[2])));
        worst = fmax(worst, fabs((double)p[1] - (double)q[1]));
        CLOSE(ea[i].irradiance[0], eb[i].irradiance[0], 1e-6 * (double)ea[i].irradiance[0]);
    }
    envlt_free(la);
    envlt_free(lb);
    sky_free(&b);
    return worst;
}

static void rotation_turns_the_lights(void **state)
{
    enum { W = 64, H = 32 };
    double worst = 0;
    (void)state;
    for (int m = 0; m < METHODS; m++)
        for (uint32_t shift = 0; shift < W; shift += 13) {
            sky a = sky_alloc(ENVLT_PROJECTION_LATLONG, W, H);
            envlt_desc d = desc_of(methods[m], 40);
            sky_fill(&a, sunny);
            worst = fmax(worst, off_when_turned(&a, &d, shift));
            sky_free(&a);
        }
    CONFORM_MAX("T21", "a turned map's lights off the turned lights", 5e-7, worst);
}

/* Only the first row is lit, or only the last. */
static void one_lit_row_turns_its_lights(void **state)
{
    uint64_t seed = 9;
    (void)state;
    for (int m = 0; m < METHODS; m++)
        for (size_t row = 0; row < 4; row += 3) {
            sky a = sky_alloc(ENVLT_PROJECTION_LATLONG, 16, 4);
            envlt_desc d = desc_of(methods[m], 3);
            for (size_t t = 0; t < 16; t++)
                for (size_t c = 0; c < 3; c++) a.rgb[3 * (16 * row + t) + c] = (float)(0.1 + rnd(&seed));
            for (uint32_t shift = 1; shift < 16; shift += 4) assert_true(off_when_turned(&a, &d, shift) < 1e-6);
            sky_free(&a);
        }
}

/* ---- T22 ---- */

static void bad_texels_are_counted(void **state)
{
    uint32_t bits[3] = { 0x7fc00000u, 0x7f800000u, 0xbf800000u };
    uint64_t counted = 0;
    (void)state;
    for (int m = 0; m < METHODS; m++) {
        sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 32, 16);
        envlt_desc d = desc_of(methods[m], 16);
        envlt_stats stats;
        envlt_lights *l;
        double found[3], expected[3];
        sky_fill(&s, studio);
        for (size_t i = 0; i < 3; i++) s.rgb[3 * (40 + 7 * i) + i] = 0;
        s.rgb[3 * 100] = 0;
        s.rgb[3 * 200 + 1] *= -0.0f;
        exact_energy(&s, expected);
        for (size_t i = 0; i < 3; i++) memcpy(s.rgb + 3 * (40 + 7 * i) + i, &bits[i], 4);
        s.rgb[3 * 100] = 3e38f;
        l = build(&d, &s.map, &stats);
        light_energy(l, found);
        counted = stats.bad_texels;
        assert_int_equal(stats.bad_texels, 4);
        for (int c = 0; c < 3; c++) CLOSE(found[c] / expected[c], 1, 1e-6);
        envlt_free(l);
        sky_free(&s);
    }
    CONFORM("T22", "texels with NaN, infinite, negative or huge channels, counted", 4, (double)counted, 0);
}

/* ---- energies of any size ---- */

/* Radiance times a power of two, up to the limit of 1e30 a texel: not a bit of a direction or an extent changes. */
static void units_change_no_direction(void **state)
{
    static const int powers[] = { -40, 10, 40, 84 };
    double moved = 0, energy = 0;
    (void)state;
    for (int m = 0; m < 2 * METHODS; m++)
        for (size_t p = 0; p < sizeof powers / sizeof powers[0]; p++) {
            sky s = m & 1 ? sky_alloc(ENVLT_PROJECTION_CUBE, 24, 24) : sky_alloc(ENVLT_PROJECTION_LATLONG, 90, 45);
            envlt_desc d = desc_of(methods[m / 2], 40);
            envlt_lights *a, *b;
            const envlt_light *la, *lb;
            uint32_t na, nb;
            sky_fill(&s, sunny);
            a = build(&d, &s.map, NULL);
            for (size_t t = 0; t < 3 * s.texels; t++) s.rgb[t] *= (float)exp2(powers[p]);
            b = build(&d, &s.map, NULL);
            la = envlt_get_lights(a, &na);
            lb = envlt_get_lights(b, &nb);
            assert_int_equal(na, nb);
            for (uint32_t i = 0; i < na; i++)
                for (int c = 0; c < 3; c++) {
                    moved = fmax(moved, fabs((double)la[i].direction[c] - (double)lb[i].direction[c]));
                    moved = fmax(moved, fabs((double)la[i].axis_u[c] - (double)lb[i].axis_u[c]));
                    moved = fmax(moved, fabs((double)la[i].axis_v[c] - (double)lb[i].axis_v[c]));
                    energy = fmax(energy, fabs((double)lb[i].irradiance[c] /
                                               ((double)la[i].irradiance[c] * exp2(powers[p])) - 1));
                }
            envlt_free(a);
            envlt_free(b);
            sky_free(&s);
        }
    CONFORM_MAX("irradiance", "directions and extents of 2^-40 to 2^84 times the radiance, off, any method", 0, moved);
    CONFORM_MAX("irradiance", "energy of 2^-40 to 2^84 times the radiance, off in proportion, relative", 0, energy);
}

/* ---- what the methods are worth ---- */

/* Issue: the best method at 128 lights is no worse than inversion at 256, on a sunny and on a studio map. */
static void best_method_halves_the_lights(void **state)
{
    static receivers r;
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 256, 128);
        double best = 1, inversion;
        envlt_desc d;
        envlt_lights *l;
        const envlt_light *list;
        uint32_t count;
        sky_fill(&s, kind ? studio : sunny);
        receivers_make(&r, &s, 96, 1);
        for (int m = 0; m < 3; m++) {
            d = desc_of(methods[m], 128);
            l = build(&d, &s.map, NULL);
            list = envlt_get_lights(l, &count);
            best = fmin(best, receivers_error(&r, list, count, 1));
            envlt_free(l);
        }
        d = desc_of(ENVLT_METHOD_CDF, 256);
        l = build(&d, &s.map, NULL);
        list = envlt_get_lights(l, &count);
        inversion = receivers_error(&r, list, count, 1);
        envlt_free(l);
        CONFORM_MAX("irradiance", kind ? "shadowed error of 128 lights over that of inversion with 256, studio map"
                                       : "shadowed error of 128 lights over that of inversion with 256, sunny map", 1,
                    best / inversion);
        sky_free(&s);
    }
}

static void jittered_frames_converge_like_a_sequence(void **state)
{
    static receivers r;
    sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 128, 64);
    envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, 32);
    static envlt_light all[32 * 64];
    const envlt_light *list;
    envlt_lights *l;
    uint32_t count, frame;
    double still, moving;
    (void)state;
    sky_fill(&s, studio);
    receivers_make(&r, &s, 96, 1);
    l = build(&d, &s.map, NULL);
    list = envlt_get_lights(l, &count);
    still = receivers_error(&r, list, count, 1);
    for (frame = 0; frame < 64; frame++) {
        assert_int_equal(envlt_jitter(l, frame, 1, all + frame * count), ENVLT_OK);
        for (uint32_t i = 0; i < count; i++)
            for (int c = 0; c < 3; c++) all[frame * count + i].irradiance[c] /= 64;
    }
    moving = receivers_error(&r, all, 64 * count, 1);
    /* 64 frames of a low-discrepancy sequence: a twentieth at 1 / n, an eighth at 1 / sqrt(n) */
    CONFORM_MAX("irradiance", "shadowed error of 64 jittered frames over one of centres", 0.125, moving / still);
    envlt_free(l);
    sky_free(&s);
}

static void sun_is_split_off(void **state)
{
    sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 256, 128);
    envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, 64);
    const double sun[3] = { 0.5270463, 0.7378648, 0.4216370 };
    const envlt_light *list;
    envlt_lights *l;
    uint32_t count;
    double cosine = 0;
    (void)state;
    d.split_sun = 1;
    sky_fill(&s, sunny);
    l = build(&d, &s.map, NULL);
    list = envlt_get_lights(l, &count);
    assert_int_equal(count, 64);
    assert_int_equal(list[0].flags, ENVLT_LIGHT_SUN);
    for (int c = 0; c < 3; c++) cosine += sun[c] * (double)list[0].direction[c];
    assert_true(cosine > cos(0.01));                            /* half a texel */
    assert_true(list[0].solid_angle < 0.01f);
    for (uint32_t i = 1; i < count; i++) {
        assert_int_equal(list[i].flags, 0);
        assert_true(list[i].irradiance[0] < 0.25f * list[0].irradiance[0]);
    }
    envlt_free(l);
    sky_fill(&s, even);                                         /* no sun: nothing to split off */
    l = build(&d, &s.map, NULL);
    assert_int_equal(envlt_get_lights(l, &count)->flags, 0);
    envlt_free(l);
    sky_free(&s);
}

static void uneven(const double *d, double *rgb)
{
    for (int c = 0; c < 3; c++) rgb[c] = 2 + 0.9 * d[0] + 0.7 * d[1] * d[2] + 0.1 * c;
}

/* Beside a sun that leaves no digit of the sky in a sum of both, the sky's lights are those of the sky alone. */
static void a_sky_beside_a_glaring_sun_keeps_its_lights(void **state)
{
    (void)state;
    for (int kind = 0; kind < 2 * METHODS; kind++) {
        sky s = kind & 1 ? sky_alloc(ENVLT_PROJECTION_CUBE, 24, 24) : sky_alloc(ENVLT_PROJECTION_LATLONG, 90, 45);
        size_t sun = 3 * (s.texels / 11);
        envlt_desc d = desc_of(methods[kind / 2], 24);
        envlt_lights *alone, *beside;
        const envlt_light *a, *b;
        uint32_t count, found;
        sky_fill(&s, uneven);
        memset(s.rgb + sun, 0, 3 * sizeof *s.rgb);
        alone = build(&d, &s.map, NULL);
        for (size_t c = 0; c < 3; c++) s.rgb[sun + c] = 1e25f;
        d.split_sun = 1;
        d.light_count++;
        beside = build(&d, &s.map, NULL);
        a = envlt_get_lights(alone, &count);
        b = envlt_get_lights(beside, &found);
        assert_int_equal(found, count + 1);
        assert_int_equal(b[0].flags, ENVLT_LIGHT_SUN);
        for (uint32_t i = 0; i < count; i++) {
            assert_memory_equal(a[i].direction, b[i + 1].direction, sizeof a->direction);
            assert_memory_equal(a[i].irradiance, b[i + 1].irradiance, sizeof a->irradiance);
        }
        envlt_free(alone);
        envlt_free(beside);
        sky_free(&s);
    }
}

/* ---- extents ---- */

static void disc_map(const double *d, double *rgb)
{
    rgb[0] = rgb[1] = rgb[2] = d[0] * 0.6 + d[1] * 0.8 > cos(0.2);
}

static void extents_measure_the_stratum(void **state)
{
    sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 512, 256);
    envlt_desc d = desc_of(ENVLT_METHOD_MEDIAN_CUT, 1);
    envlt_lights *l;
    const envlt_light *list;
    uint32_t count;
    (void)state;
    sky_fill(&s, disc_map);
    l = build(&d, &s.map, NULL);
    list = envlt_get_lights(l, &count);
    assert_int_equal(count, 1);
    for (int axis = 0; axis < 2; axis++) {
        const float *a = axis ? list[0].axis_v : list[0].axis_u;
        double length = sqrt((double)(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]));
        const float *to = list[0].direction;
        double along = (double)(a[0] * to[0] + a[1] * to[1] + a[2] * to[2]);
        CLOSE(length, 0.2, 0.003);                 /* texels of 0.012, projection of sin 0.2 */
        CLOSE(along, 0, 1e-6);
    }
    envlt_free(l);
    sky_free(&s);
}

/* ---- follow, match, rotate ---- */

static double video_time;
static void video(const double *d, double *rgb)
{
    double a = 0.02 * video_time;
    sunny(d, rgb);
    rgb[0] += 30 * lobe(d, cos(a), 0.5, sin(a), 60);
    rgb[1] += 20 * lobe(d, cos(a), 0.5, sin(a), 60);
}

static void follow_moves_little(void **state)
{
    double worst = 0, scratch = 0, energy = 0;
    uint32_t changed = 0;
    (void)state;
    for (int m = 0; m < 3; m++) {
        sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 128, 64);
        envlt_desc d = desc_of(methods[m], 60);
        envlt_stats stats;
        envlt_lights *l, *fresh;
        envlt_light old[60];
        uint32_t count;
        const envlt_light *list;
        double found[3], expected[3];
        video_time = 0;
        sky_fill(&s, video);
        l = build(&d, &s.map, NULL);
        list = envlt_get_lights(l, &count);
        memcpy(old, list, count * sizeof *old);
        assert_int_equal(envlt_follow(l, &s.map, 0, &stats), ENVLT_OK);
        assert_memory_equal(old, envlt_get_lights(l, &count), count * sizeof *old);      /* a still map: not a bit */
        assert_true(stats.largest_move <= 0 && stats.changed == 0);
        for (video_time = 1; video_time < 12; video_time++) {
            sky_fill(&s, video);
            list = envlt_get_lights(l, &count);
            memcpy(old, list, count * sizeof *old);
            assert_int_equal(envlt_follow(l, &s.map, 0, &stats), ENVLT_OK);
            worst = fmax(worst, (double)stats.mean_move);
            light_energy(l, found);
            exact_energy(&s, expected);
            for (int c = 0; c < 3; c++) energy = fmax(energy, fabs(found[c] / expected[c] - 1));
            assert_true(strata_error(&s, l) < 1e-6);
            if (m == 2) {                                       /* built anew and matched: what following is worth */
                double sum = 0, weight = 0;
                const envlt_light *from;
                envlt_light to[60];
                uint32_t n;
                fresh = build(&d, &s.map, NULL);
                from = envlt_get_lights(fresh, &n);
                memcpy(to, from, n * sizeof *to);
                assert_int_equal(envlt_match(old, count, to, n), ENVLT_OK);
                for (uint32_t i = 0; i < n && i < count; i++) {
                    double c = 0;
                    for (int k = 0; k < 3; k++) c += (double)old[i].direction[k] * (double)to[i].direction[k];
                    sum += acos(fmin(c, 1)) * (double)to[i].irradiance[1];
                    weight += (double)to[i].irradiance[1];
                }
                scratch = fmax(scratch, sum / weight);
                envlt_free(fresh);
            }
        }
        video_time = 100;                                       /* the lamp jumps: some lights have to begin anew */
        sky_fill(&s, video);
        for (int i = 0; i < 6; i++) {
            assert_int_equal(envlt_follow(l, &s.map, 0, &stats), ENVLT_OK);
            assert_in_range(stats.changed, 0, 60 / 8);
            assert_int_equal(stats.lights, count);
            changed += stats.changed;
        }
        assert_true(strata_error(&s, l) < 1e-6);
        envlt_free(l);
        sky_free(&s);
    }
    CONFORM_MAX("irradiance", "energy of followed lights off the map, relative", 1e-6, energy);
    /* the lamp itself moves 0.018 a frame and has half of the energy that moves at all */
    CONFORM_MAX("irradiance", "mean move of followed lights a frame, radians", 0.018, worst);
    CONFORM_MIN("irradiance", "mean move of lights built anew over followed ones", 1.5, scratch / worst);
    assert_true(changed > 0);
}

/* A sun of 4 degrees that wanders, over an even sky of radiance video_sky. */
static double video_sky;
static void wandering_sun(const double *d, double *rgb)
{
    double a = 0.04 * video_time;
    int c;
    for (c = 0; c < 3; c++) rgb[c] = video_sky + 2000 * (1 + c) * lobe(d, cos(a), 0.5, sin(a), 2000);
}

static void sun_is_followed(void **state)
{
    (void)state;
    for (int dark = 0; dark < 2; dark++) {       /* in the dark all other strata are without energy */
        sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 128, 64);
        envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, 32);
        envlt_lights *l;
        video_sky = dark ? 0 : 0.5;
        video_time = 0;
        d.split_sun = 1;
        sky_fill(&s, wandering_sun);
        l = build(&d, &s.map, NULL);
        for (video_time = 1; video_time < 20; video_time++) {
            double a = 0.04 * video_time, to[3] = { cos(a), 0.5, sin(a) }, cosine = 0, found[3], expected[3];
            uint32_t count;
            const envlt_light *list;
            sky_fill(&s, wandering_sun);
            assert_int_equal(envlt_follow(l, &s.map, 0, NULL), ENVLT_OK);
            list = envlt_get_lights(l, &count);
            assert_int_equal(count, 32);
            light_energy(l, found);
            exact_energy(&s, expected);
            for (int c = 0; c < 3; c++) {
                assert_true(fabs(found[c] / expected[c] - 1) < 1e-6);
                cosine += to[c] / sqrt(1.25) * (double)list[0].direction[c];
            }
            assert_true(strata_error(&s, l) < 1e-6);
            assert_int_equal(list[0].flags, ENVLT_LIGHT_SUN);
            if (!(cosine > cos(0.01))) fail_msg("frame %g: the sun's light is %g from it", video_time, acos(cosine));
            assert_true(list[0].irradiance[1] > 0.7f * (float)expected[1] || !dark);
        }
        envlt_free(l);
        sky_free(&s);
    }
}

/* A spot of `size` x `size` texels with its corner at x, y. */
static void spot(sky *s, size_t x, size_t y, size_t size, float radiance)
{
    for (size_t j = y; j < y + size; j++)
        for (size_t i = x; i < x + size; i++)
            for (size_t c = 0; c < 3; c++) s->rgb[3 * (j * s->map.width + i) + c] = radiance;
}

/* The lights' energy is the map's, they are as many as expected, and fit for shadow maps. */
static void lights_are_whole(const sky *s, const envlt_lights *l, uint32_t expected, int has_sun)
{
    double found[3], exact[3];
    uint32_t count;
    const envlt_light *list = envlt_get_lights(l, &count);
    assert_int_equal(count, expected);
    light_energy(l, found);
    exact_energy(s, exact);
    for (int c = 0; c < 3; c++) CLOSE(found[c], exact[c], 1e-6 * exact[c]);
    assert_true(strata_error(s, l) < 1e-6);
    for (uint32_t i = 0; i < count; i++) {
        assert_true(light_is_finite(&list[i]));
        assert_int_equal(list[i].flags, has_sun && i == 0 ? ENVLT_LIGHT_SUN : 0);
        for (uint32_t j = 0; j < i; j++) assert_int_not_equal(list[i].id, list[j].id);
    }
}

/* The first frame has few lit texels, or a sun and nothing else: as soon as there are more, all lights come. */
static void a_black_first_frame_starves_none(void **state)
{
    (void)state;
    for (int kind = 0; kind < 4 * METHODS; kind++) {
        int sun = kind & 1, ask = kind & 2;
        sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 128, 64);
        envlt_desc d = desc_of(methods[kind / 4], 32);
        envlt_light old[32];
        envlt_lights *l;
        envlt_stats stats;
        uint32_t count;
        d.split_sun = sun;
        spot(&s, 30, 20, sun ? 2 : 1, 1000);
        if (!sun) spot(&s, 90, 30, 1, 2);
        l = build(&d, &s.map, NULL);
        memcpy(old, envlt_get_lights(l, &count), sizeof *old);
        lights_are_whole(&s, l, sun ? 1 : 2, sun);
        for (int i = 0; i < 2; i++) {                           /* still black: nothing moves */
            assert_int_equal(envlt_follow(l, &s.map, ask ? 32 : 0, &stats), ENVLT_OK);
            if (i || methods[kind / 4] != ENVLT_METHOD_CDF)
                assert_memory_equal(old, envlt_get_lights(l, &count), sizeof *old);
            lights_are_whole(&s, l, sun ? 1 : 2, sun);
            memcpy(old, envlt_get_lights(l, &count), sizeof *old);
        }
        for (size_t t = 0; t < 3 * s.texels; t++) s.rgb[t] += (float)(1 + t % 3);
        assert_int_equal(envlt_follow(l, &s.map, ask ? 32 : 0, &stats), ENVLT_OK);
        envlt_get_lights(l, &count);
        /* inversion joins cells that fall into one column */
        assert_in_range(count, methods[kind / 4] == ENVLT_METHOD_VARIANCE ? 32 : 16, 32);
        lights_are_whole(&s, l, count, sun);
        assert_int_equal(stats.lights, count);
        memcpy(old, envlt_get_lights(l, &count), count * sizeof *old);
        assert_int_equal(envlt_follow(l, &s.map, 0, &stats), ENVLT_OK);
        if (methods[kind / 4] != ENVLT_METHOD_CDF)
            assert_memory_equal(old, envlt_get_lights(l, &count), count * sizeof *old);
        envlt_free(l);
        sky_free(&s);
    }
}

/* A sun comes up, goes out, comes back elsewhere: it is light 0, and few of the others begin anew. */
static void sun_comes_up(void **state)
{
    static const size_t places[][2] = { { 30, 20 }, { 30, 20 }, { 100, 10 }, { 101, 10 } };
    sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 128, 64);
    envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, 32);
    envlt_stats stats;
    envlt_lights *l;
    (void)state;
    d.split_sun = 1;
    sky_fill(&s, even);
    l = build(&d, &s.map, NULL);
    lights_are_whole(&s, l, 32, 0);
    assert_int_equal(envlt_follow(l, &s.map, 0, &stats), ENVLT_OK);
    lights_are_whole(&s, l, 32, 0);
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        double to[3], omega, cosine = 0;
        const envlt_light *list;
        sky_fill(&s, even);
        spot(&s, places[i][0], places[i][1], 1, 5000);
        sky_texel(&s, places[i][1] * 128 + places[i][0], to, &omega);
        assert_int_equal(envlt_follow(l, &s.map, 0, &stats), ENVLT_OK);
        lights_are_whole(&s, l, 32, 1);
        assert_in_range(stats.changed, 0, 1 + 32 / 8);
        list = envlt_get_lights(l, NULL);
        for (int c = 0; c < 3; c++) cosine += to[c] * (double)list[0].direction[c];
        assert_true(cosine > 1 - 1e-6);
        if (i == 1) {                                           /* none for a frame */
            sky_fill(&s, even);
            assert_int_equal(envlt_follow(l, &s.map, 0, &stats), ENVLT_OK);
            lights_are_whole(&s, l, 32, 1);
        }
    }
    envlt_free(l);
    sky_free(&s);
}

/* One light is no sun and the sky, but all of it. */
static void one_light_takes_the_sun_too(void **state)
{
    sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 128, 64);
    envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, 16);
    envlt_lights *l;
    (void)state;
    d.split_sun = 1;
    sky_fill(&s, even);
    spot(&s, 30, 20, 1, 5000);
    l = build(&d, &s.map, NULL);
    lights_are_whole(&s, l, 16, 1);
    assert_int_equal(envlt_follow(l, &s.map, 1, NULL), ENVLT_OK);
    lights_are_whole(&s, l, 1, 0);
    assert_int_equal(envlt_follow(l, &s.map, 0, NULL), ENVLT_OK);
    lights_are_whole(&s, l, 1, 0);
    assert_int_equal(envlt_follow(l, &s.map, 16, NULL), ENVLT_OK);
    lights_are_whole(&s, l, 16, 1);
    envlt_free(l);
    sky_free(&s);
}

/* The sun moves onto the only texel of another light. That one divides another stratum, or has none and stays. */
static void a_light_whose_stratum_the_sun_takes_divides_another_or_stays(void **state)
{
    enum { W = 40, H = 20, K = W * H };
    (void)state;
    for (int spare = 0; spare < 2; spare++) {
        sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, W, H);
        envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, K);
        static envlt_light jittered[K];
        const envlt_light *list;
        const uint32_t *strata;
        envlt_lights *l;
        uint32_t count, empty = 0;
        size_t at = 0, from = 2 * W + 9;
        d.split_sun = 1;
        sky_fill(&s, even);
        for (size_t c = 0; c < 3; c++) s.rgb[3 * from + c] = 1e4f;
        l = build(&d, &s.map, NULL);
        lights_are_whole(&s, l, K, 1);
        strata = envlt_strata(l, NULL);
        while (strata[at] != K - 1) at++;                       /* the last stratum: nothing lies beyond it */
        for (size_t c = 0; c < 3; c++) s.rgb[3 * from + c] = spare ? 1 : 0;
        for (size_t c = 0; c < 3; c++) s.rgb[3 * at + c] = 1e4f;
        assert_int_equal(envlt_follow(l, &s.map, 0, NULL), ENVLT_OK);
        list = envlt_get_lights(l, &count);
        assert_int_equal(count, K);
        assert_int_equal(envlt_jitter(l, 3, 5, jittered), ENVLT_OK);
        for (uint32_t i = 0; i < K; i++)
            if (!(list[i].solid_angle > 0)) {
                assert_memory_equal(&jittered[i], &list[i], sizeof *list);
                empty++;
            }
        assert_int_equal(empty, spare ? 0 : 1);
        envlt_free(l);
        sky_free(&s);
    }
}

static void another_count_changes_few(void **state)
{
    sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 128, 64);
    envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, 40);
    static const uint32_t counts[] = { 41, 64, 200, 199, 100, 7, 1, 12 };
    envlt_lights *l;
    uint32_t before;
    (void)state;
    sky_fill(&s, studio);
    l = build(&d, &s.map, NULL);
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        envlt_light old[200];
        uint32_t count, kept = 0;
        const envlt_light *list = envlt_get_lights(l, &before);
        memcpy(old, list, before * sizeof *old);
        assert_int_equal(envlt_follow(l, &s.map, counts[i], NULL), ENVLT_OK);
        list = envlt_get_lights(l, &count);
        assert_int_equal(count, counts[i]);
        assert_true(strata_error(&s, l) < 1e-6);
        for (uint32_t a = 0; a < count; a++)
            for (uint32_t b = 0; b < before; b++)
                kept += list[a].id == old[b].id && memcmp(list[a].direction, old[b].direction, 12) == 0;
        if (i == 0) assert_true(kept >= 39);        /* one more light: one stratum was cut */
        if (i == 3) assert_true(kept >= 198);       /* one less: two were joined */
    }
    envlt_free(l);
    sky_free(&s);
}

static envlt_light light_at(double degrees, float radiance, uint32_t id)
{
    envlt_light l;
    memset(&l, 0, sizeof l);
    l.direction[0] = (float)cos(degrees * PI / 180);
    l.direction[2] = (float)sin(degrees * PI / 180);
    for (int c = 0; c < 3; c++) l.irradiance[c] = radiance;
    l.id = id;
    return l;
}

/* The brightest choose first, and none of them is lost when there are fewer than before. */
static void bright_lights_are_matched_first(void **state)
{
    const envlt_light previous[4] = { light_at(0, 1, 7), light_at(100, 1, 3), light_at(200, 1, 4),
                                      light_at(10, 90, 12) };
    envlt_light now[6];
    (void)state;
    now[0] = light_at(8, 80, 0);                        /* dim 7 is first in the list, bright 12 is what moved */
    now[1] = light_at(60, 1, 0);
    assert_int_equal(envlt_match(previous, 4, now, 2), ENVLT_OK);
    assert_true(now[0].id == 7 || now[1].id == 7);
    for (int i = 0; i < 2; i++) assert_true((now[i].id == 12) == (now[i].irradiance[0] > 50));
    assert_int_equal(now[0].id, 7);                     /* whose place there still is */

    now[0] = light_at(8, 80, 0);
    assert_int_equal(envlt_match(previous, 4, now, 1), ENVLT_OK);
    assert_int_equal(now[0].id, 12);

    for (int i = 0; i < 6; i++) now[i] = light_at(8 + 45 * i, i == 0 ? 80 : 1, 0);
    assert_int_equal(envlt_match(previous, 4, now, 6), ENVLT_OK);
    for (int i = 0; i < 4; i++) assert_int_equal(now[i].id, previous[i].id);
    assert_true(now[3].irradiance[0] > 50);
    CLOSE(now[1].direction[2], sin(98 * PI / 180), 1e-6);
    CLOSE(now[2].direction[2], sin(188 * PI / 180), 1e-6);
    for (uint32_t i = 4; i < 6; i++) assert_int_equal(now[i].id, 13 + i - 4);

    now[0] = light_at(8, NAN, 0);                       /* not a number is dark, and ends all the same */
    now[1] = light_at(190, INFINITY, 0);
    assert_int_equal(envlt_match(now, 2, now + 2, 3), ENVLT_OK);
}

/* Every previous light finds its own again, whatever the order: places and ids are as they were. */
static void match_undoes_a_shuffle(void **state)
{
    enum { K = 40 };
    uint64_t seed = 5;
    envlt_light previous[K], now[K];
    (void)state;
    for (uint32_t i = 0; i < K; i++)
        previous[i] = light_at(360.0 * i / K + 3 * rnd(&seed), (float)(1 + (i * 7) % 5), 100 + (i * 11) % K);
    memcpy(now, previous, sizeof now);
    for (uint32_t i = K - 1; i > 0; i--) {
        uint32_t j = (uint32_t)(rnd(&seed) * (i + 1));
        envlt_light moved = now[i];
        now[i] = now[j];
        now[j] = moved;
    }
    for (uint32_t i = 0; i < K; i++) now[i].id = i;
    assert_int_equal(envlt_match(previous, K, now, K), ENVLT_OK);
    assert_memory_equal(now, previous, sizeof now);
}

static void envlt_rotate_turns_directions_and_axes(void **state)
{
    sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 64, 32);
    const float quarter[16] = { 0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1 };      /* +X to -Z */
    envlt_light list[16], turned[16];
    envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, 16);
    envlt_lights *l;
    uint32_t count;
    (void)state;
    sky_fill(&s, sunny);
    l = build(&d, &s.map, NULL);
    memcpy(list, envlt_get_lights(l, &count), sizeof list);
    memcpy(turned, list, sizeof list);
    assert_int_equal(envlt_rotate(turned, count, quarter), ENVLT_OK);
    for (uint32_t i = 0; i < count; i++) {
        CLOSE(turned[i].direction[0], list[i].direction[2], 1e-6);
        CLOSE(turned[i].direction[2], -list[i].direction[0], 1e-6);
        CLOSE(turned[i].axis_u[2], -list[i].axis_u[0], 1e-6);
    }
    envlt_free(l);
    sky_free(&s);
}

/* Rows of very unequal energy: the median of a strip may lie in the row before it. */
static void a_light_of_inversion_lies_in_its_own_stratum(void **state)
{
    uint64_t seed = 3;
    (void)state;
    for (uint32_t map = 0; map < 40; map++) {
        sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 12, 12);
        envlt_desc desc = desc_of(ENVLT_METHOD_CDF, 2 + map % 14);
        const envlt_light *list;
        envlt_lights *l;
        uint32_t count;
        for (uint32_t y = 0; y < 12; y++) {
            double row = exp(8 * rnd(&seed));
            for (uint32_t x = 0; x < 12; x++)
                for (size_t c = 0; c < 3; c++) s.rgb[3 * (12 * y + x) + c] = (float)(row * (1 + rnd(&seed)));
        }
        l = build(&desc, &s.map, NULL);
        list = envlt_get_lights(l, &count);
        for (uint32_t i = 0; i < count; i++) {
            size_t at = 0;
            double d[3], omega, most = -1;
            for (size_t t = 0; t < s.texels; t++) {
                double cosine = 0;
                sky_texel(&s, t, d, &omega);
                for (int c = 0; c < 3; c++) cosine += d[c] * (double)list[i].direction[c];
                if (cosine > most) most = cosine, at = t;
            }
            assert_true(most > 0.999999);
            assert_int_equal(l->strata[at], i);
        }
        envlt_free(l);
        sky_free(&s);
    }
}

/* ---- residual, export ---- */

static void residual_has_no_mean(void **state)
{
    double mean = 0, first = 0, with = 0, without = 0;
    (void)state;
    for (int cube = 0; cube < 2; cube++) {
        sky s = cube ? sky_alloc(ENVLT_PROJECTION_CUBE, 32, 32) : sky_alloc(ENVLT_PROJECTION_LATLONG, 128, 64);
        float *rest = (float *)malloc(3 * s.texels * sizeof *rest), sh[27];
        envlt_desc desc = desc_of(ENVLT_METHOD_DEFAULT, 24);
        double sum[3] = { 0, 0, 0 }, d[3], omega, energy[3];
        envlt_lights *l;
        const envlt_light *list;
        uint32_t count;
        static receivers r;
        assert_non_null(rest);
        sky_fill(&s, studio);
        l = build(&desc, &s.map, NULL);
        list = envlt_get_lights(l, &count);
        assert_int_equal(envlt_residual(l, &s.map, rest), ENVLT_OK);
        exact_energy(&s, energy);
        for (size_t t = 0; t < s.texels; t++) {
            sky_texel(&s, t, d, &omega);
            for (size_t c = 0; c < 3; c++) sum[c] += omega * (double)rest[3 * t + c];
        }
        for (int c = 0; c < 3; c++) mean = fmax(mean, fabs(sum[c] / energy[c]));
        assert_int_equal(envlt_residual_sh(l, &s.map, sh), ENVLT_OK);
        for (int c = 0; c < 3; c++) first = fmax(first, fabs((double)sh[c]) / energy[c]);
        receivers_make(&r, &s, 64, 0);
        for (size_t i = 0; i < r.count; i++) {
            float n[3], e[3];
            double lit[3] = { 0, 0, 0 }, exact = r.exact[i];
            for (int c = 0; c < 3; c++) n[c] = (float)r.n[i][c];
            envlt_sh_irradiance(sh, n, e);
            for (uint32_t k = 0; k < count; k++) {
                double cosine = 0;
                for (int c = 0; c < 3; c++) cosine += r.n[i][c] * (double)list[k].direction[c];
                for (int c = 0; c < 3 && cosine > 0; c++) lit[c] += cosine * (double)list[k].irradiance[c];
            }
            without += pow(0.2126 * lit[0] + 0.7152 * lit[1] + 0.0722 * lit[2] - exact, 2);
            for (int c = 0; c < 3; c++) lit[c] += (double)e[c];
            with += pow(0.2126 * lit[0] + 0.7152 * lit[1] + 0.0722 * lit[2] - exact, 2);
        }
        envlt_free(l);
        free(rest);
        sky_free(&s);
    }
    CONFORM_MAX("irradiance", "mean of the residual map over the map's, any channel", 1e-6, mean);
    CONFORM_MAX("irradiance", "constant term of the residual's harmonics, relative", 1e-6, first);
    /* orders 0 to 2 are exact then; single lights have most of their error in orders of 4 and more */
    CONFORM_MAX("irradiance", "unshadowed error of 24 lights with residual over that without", 0.9,
                sqrt(with / without));
}

static void gltf_is_written(void **state)
{
    sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 64, 32);
    envlt_desc d = desc_of(ENVLT_METHOD_DEFAULT, 3);
    envlt_lights *l;
    const envlt_light *list;
    uint32_t count;
    char text[4096], cut[64];
    size_t size;
    const char *at;
    (void)state;
    sky_fill(&s, sunny);
    l = build(&d, &s.map, NULL);
    list = envlt_get_lights(l, &count);
    size = envlt_gltf_bytes(list, count);
    assert_true(size > 500 && size < sizeof text);
    assert_int_equal(envlt_gltf_write(list, count, text, sizeof text), ENVLT_OK);
    assert_int_equal(strlen(text) + 1, size);
    memset(cut, 'x', sizeof cut);
    assert_int_equal(envlt_gltf_write(list, count, cut, sizeof cut), ENVLT_ERR_MEMORY);
    assert_int_equal(cut[0], 'x');
    at = text;
    for (uint32_t i = 0; i < count; i++) {                      /* colour x intensity is the irradiance, to the bit */
        double color[3], intensity;
        at = strstr(at, "\"color\":[");
        assert_non_null(at);
        assert_int_equal(sscanf(at, "\"color\":[%lf,%lf,%lf],\"intensity\":%lf", &color[0], &color[1], &color[2],
                                &intensity), 4);
        for (int c = 0; c < 3; c++)
            CLOSE(color[c] * intensity, list[i].irradiance[c], 2e-7 * intensity);
        at++;
    }
    at = text;
    for (uint32_t i = 0; i < count; i++) {                      /* +Z turned by the node's rotation is the direction */
        double q[4];
        at = strstr(at, "\"rotation\":[");
        assert_non_null(at);
        assert_int_equal(sscanf(at, "\"rotation\":[%lf,%lf,%lf,%lf]", &q[0], &q[1], &q[2], &q[3]), 4);
        CLOSE(2 * (q[0] * q[2] + q[3] * q[1]), list[i].direction[0], 1e-6);
        CLOSE(2 * (q[1] * q[2] - q[3] * q[0]), list[i].direction[1], 1e-6);
        CLOSE(1 - 2 * (q[0] * q[0] + q[1] * q[1]), list[i].direction[2], 1e-6);
        at++;
    }
    envlt_free(l);
    sky_free(&s);
}

/* ---- pieces that whole results hardly show ---- */

/* Across an edge of the cube: the nearest texel of the face there, another face for each of the four edges. */
static void texels_beyond_a_face_are_those_of_the_next(void **state)
{
    enum { SIDE = 8 };
    static const int beyond[4][2] = { { -1, 0 }, { SIDE, 0 }, { 0, -1 }, { 0, SIDE } };
    sky s = sky_alloc(ENVLT_PROJECTION_CUBE, SIDE, SIDE);
    (void)state;
    for (uint32_t face = 0; face < 6; face++)
        for (uint32_t i = 0; i < SIDE; i++) {
            uint32_t seen = 1u << face;
            for (int e = 0; e < 4; e++) {
                int x = beyond[e][0] ? beyond[e][0] : beyond[e][1] ? (int)i : 0;
                int y = beyond[e][1] ? beyond[e][1] : (int)i;
                uint32_t here = (face * SIDE + (uint32_t)(y < 0 ? 0 : y >= SIDE ? SIDE - 1 : y)) * SIDE +
                                (uint32_t)(x < 0 ? 0 : x >= SIDE ? SIDE - 1 : x), best = 0;
                uint32_t there = envlt__cube_texel(SIDE, face, x, y), other = there / (SIDE * SIDE);
                double d[3], n[3], omega, most = -1;
                seen |= 1u << other;
                sky_texel(&s, here, d, &omega);
                for (uint32_t t = other * SIDE * SIDE; t < (other + 1) * SIDE * SIDE; t++) {
                    double dot;
                    sky_texel(&s, t, n, &omega);
                    dot = d[0] * n[0] + d[1] * n[1] + d[2] * n[2];
                    if (dot > most) most = dot, best = t;
                }
                assert_int_equal(there, best);
            }
            assert_int_equal(seen, 63u & ~(1u << (face ^ 1)));
        }
    sky_free(&s);
}

/* Sky 1 + x / 2 + xy + (3 z^2 - 1): each order times pi, 2 pi / 3, pi / 4 (Ramamoorthi and Hanrahan 2001). */
static void harmonics_give_irradiance_in_closed_form(void **state)
{
    static const float normals[3][3] = { { 0.6f, 0.8f, 0 }, { 0.36f, 0.48f, 0.8f }, { -0.48f, 0.6f, 0.64f } };
    float sh[27] = { 0 }, rgb[3];
    (void)state;
    sh[0] = 3.54490770f;
    sh[3 * 3] = 0.5f / 0.488602512f;
    sh[3 * 4] = 1 / 1.09254843f;
    sh[3 * 6 + 1] = 1 / 0.315391565f;
    for (int i = 0; i < 3; i++) {
        double x = (double)normals[i][0], y = (double)normals[i][1], z = (double)normals[i][2];
        envlt_sh_irradiance(sh, normals[i], rgb);
        assert_true(fabs((double)rgb[0] - (PI + PI / 3 * x + PI / 4 * x * y)) < 1e-5);
        assert_true(fabs((double)rgb[1] - PI / 4 * (3 * z * z - 1)) < 1e-5);
        assert_true(fabs((double)rgb[2]) < 1e-6);
    }
}

/* The nine harmonics of orders 0 to 2, in their order: polynomials over the root of the integral of their squares. */
static void harmonics_of(const double *d, double *y)
{
    const double x = d[0], u = d[1], z = d[2];
    const double polynomial[9] = { 1, u, z, x, x * u, u * z, 3 * z * z - 1, x * z, x * x - u * u };
    const double square[9] = { 4,        4 / 3.0,  4 / 3.0, 4 / 3.0, 4 / 15.0,
                               4 / 15.0, 16 / 5.0, 4 / 15.0, 16 / 15.0 };
    for (int j = 0; j < 9; j++) y[j] = polynomial[j] / sqrt(square[j] * PI);
}

static void each_harmonic_of_the_residual_is_the_maps_without_the_lights(void **state)
{
    (void)state;
    for (int cube = 0; cube < 2; cube++) {
        sky s = cube ? sky_alloc(ENVLT_PROJECTION_CUBE, 8, 8) : sky_alloc(ENVLT_PROJECTION_LATLONG, 24, 12);
        envlt_desc desc = desc_of(ENVLT_METHOD_DEFAULT, 5);
        double sum[27] = { 0 }, y[9], d[3], omega, energy[3];
        const envlt_light *list;
        envlt_lights *l;
        uint32_t count;
        float sh[27];
        sky_fill(&s, studio);
        l = build(&desc, &s.map, NULL);
        list = envlt_get_lights(l, &count);
        assert_int_equal(count, 5);
        exact_energy(&s, energy);
        for (size_t t = 0; t < s.texels; t++) {
            sky_texel(&s, t, d, &omega);
            harmonics_of(d, y);
            for (size_t j = 0; j < 27; j++) sum[j] += omega * (double)s.rgb[3 * t + j % 3] * y[j / 3];
        }
        for (uint32_t k = 0; k < count; k++) {
            for (int c = 0; c < 3; c++) d[c] = (double)list[k].direction[c];
            harmonics_of(d, y);
            for (int j = 0; j < 27; j++) sum[j] -= (double)list[k].irradiance[j % 3] * y[j / 3];
        }
        assert_int_equal(envlt_residual_sh(l, &s.map, sh), ENVLT_OK);
        for (int j = 0; j < 27; j++) CLOSE(sh[j], sum[j], 2e-6 * energy[j % 3]);
        envlt_free(l);
        sky_free(&s);
    }
}

/* By each harmonic alone: pi, 2 pi / 3 and pi / 4 times the harmonic. */
static void each_harmonic_gives_its_irradiance(void **state)
{
    static const float normal[3] = { 0.48f, 0.6f, -0.64f };
    double d[3], y[9];
    (void)state;
    for (int c = 0; c < 3; c++) d[c] = (double)normal[c];
    harmonics_of(d, y);
    for (int j = 0; j < 27; j++) {
        float sh[27] = { 0 }, rgb[3];
        sh[j] = 1;
        envlt_sh_irradiance(sh, normal, rgb);
        for (int c = 0; c < 3; c++)
            CLOSE(rgb[c], c == j % 3 ? PI * y[j / 3] / (j < 3 ? 1 : j < 12 ? 1.5 : 4) : 0, 1e-6);
    }
}

/* Two halves of a stratum's energy, 0.1 from its middle along a known axis: scatter w 0.01. */
static void the_main_axis_of_two_halves_is_found(void **state)
{
    static const double along[3] = { 0.36, 0.48, 0.8 }, middle[3] = { 0.2, -0.3, 0.5 };
    static const int at[6][2] = { { 0, 0 }, { 0, 1 }, { 0, 2 }, { 1, 1 }, { 1, 2 }, { 2, 2 } };
    envlt__sums sums;
    envlt__v3 axis;
    double scatter, dot;
    (void)state;
    memset(&sums, 0, sizeof sums);
    for (int side = -1; side <= 1; side += 2) {
        double p[3];
        for (int c = 0; c < 3; c++) {
            p[c] = middle[c] + side * 0.1 * along[c];
            sums.m[c] += 1.5 * p[c];
        }
        for (int k = 0; k < 6; k++) sums.s[k] += 1.5 * p[at[k][0]] * p[at[k][1]];
        sums.w += 1.5;
    }
    scatter = envlt__main_axis(&sums, &axis);
    dot = along[0] * (double)axis.x + along[1] * (double)axis.y + along[2] * (double)axis.z;
    assert_true(fabs(scatter - 3 * 0.01) < 1e-9);
    assert_true(fabs(fabs(dot) - 1) < 1e-6);
}

/* Strata of equal energy merge with the one whose middle is nearest. */
static void partners_are_nearest(void **state)
{
    static const double places[4][3] = { { 0, 0, 0 }, { 0.1, 0.5, 0 }, { 0.4, 0, 0.05 }, { 0.4, 0.45, 0.2 } };
    envlt__sums sums[4];
    envlt_lights l;
    envlt__follow f;
    uint32_t partner[4];
    double cost[4], gain[4];
    uint8_t touched[4];
    (void)state;
    memset(sums, 0, sizeof sums);
    memset(&l, 0, sizeof l);
    memset(&f, 0, sizeof f);
    for (int turn = 0; turn < 3; turn++) {       /* each axis in turn decides */
        for (int i = 0; i < 4; i++) {
            sums[i].w = 2;
            for (int c = 0; c < 3; c++) sums[i].m[c] = 2 * places[i][(c + turn) % 3];
        }
        l.sums = sums;
        l.count = 4;
        f.l = &l;
        f.partner = partner;
        f.cost = cost;
        f.gain = gain;
        f.touched = touched;
        envlt__rate_strata(&f);
        for (uint32_t i = 0; i < 4; i++) {
            uint32_t nearest = i;
            double least = 1e30;
            for (uint32_t j = 0; j < 4; j++) {
                double d2 = 0;
                for (int c = 0; c < 3; c++) d2 += pow(places[i][c] - places[j][c], 2);
                if (j != i && d2 < least) least = d2, nearest = j;
            }
            assert_int_equal(partner[i], nearest);
        }
    }
}

/* A stratum whose energy is all in one texel, or in none, cannot be split: no light without a direction. */
static void what_is_split_has_energy_on_both_sides(void **state)
{
    (void)state;
    for (uint32_t seed = 0; seed < 200; seed++) {
        sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 3 + seed % 5, 1 + seed / 5 % 4);
        envlt_desc d = desc_of(methods[seed % METHODS], 1 + seed % 3);
        uint32_t random = seed, lit = 0, count, had;
        envlt_lights *l;
        const envlt_light *list;
        sky_fill(&s, uneven);
        l = build(&d, &s.map, NULL);
        envlt_get_lights(l, &had);
        for (size_t t = 0; t < s.texels; t++) {
            float f;
            random = random * 747796405u + 2891336453u;
            f = random >> 16 & 1 ? 0 : (float)exp2((double)(random >> 24) / 4 - 32);
            lit += f > 0;
            for (size_t c = 0; c < 3; c++) s.rgb[3 * t + c] = f;
        }
        assert_int_equal(envlt_follow(l, &s.map, 60, NULL), ENVLT_OK);
        list = envlt_get_lights(l, &count);
        assert_in_range(count, had, had + lit);
        for (uint32_t i = 0; i < count; i++) {
            assert_true(light_is_finite(&list[i]));
            assert_true(i < had || list[i].irradiance[0] > 0);
        }
        envlt_free(l);
        sky_free(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(latitude_is_weighted),
        cmocka_unit_test(solid_angles_are_exact),
        cmocka_unit_test(no_light_comes_from_an_empty_texel),
        cmocka_unit_test(inversion_keeps_in_range),
        cmocka_unit_test(jitter_is_in_proportion),
        cmocka_unit_test(red_stays_red),
        cmocka_unit_test(energy_is_exact),
        cmocka_unit_test(sums_are_double),
        cmocka_unit_test(one_texel_is_one_light),
        cmocka_unit_test(seam_is_no_edge),
        cmocka_unit_test(rotation_turns_the_lights),
        cmocka_unit_test(one_lit_row_turns_its_lights),
        cmocka_unit_test(bad_texels_are_counted),
        cmocka_unit_test(units_change_no_direction),
        cmocka_unit_test(best_method_halves_the_lights),
        cmocka_unit_test(jittered_frames_converge_like_a_sequence),
        cmocka_unit_test(sun_is_split_off),
        cmocka_unit_test(a_sky_beside_a_glaring_sun_keeps_its_lights),
        cmocka_unit_test(extents_measure_the_stratum),
        cmocka_unit_test(follow_moves_little),
        cmocka_unit_test(sun_is_followed),
        cmocka_unit_test(a_black_first_frame_starves_none),
        cmocka_unit_test(sun_comes_up),
        cmocka_unit_test(one_light_takes_the_sun_too),
        cmocka_unit_test(a_light_whose_stratum_the_sun_takes_divides_another_or_stays),
        cmocka_unit_test(another_count_changes_few),
        cmocka_unit_test(bright_lights_are_matched_first),
        cmocka_unit_test(match_undoes_a_shuffle),
        cmocka_unit_test(envlt_rotate_turns_directions_and_axes),
        cmocka_unit_test(a_light_of_inversion_lies_in_its_own_stratum),
        cmocka_unit_test(residual_has_no_mean),
        cmocka_unit_test(gltf_is_written),
        cmocka_unit_test(texels_beyond_a_face_are_those_of_the_next),
        cmocka_unit_test(harmonics_give_irradiance_in_closed_form),
        cmocka_unit_test(each_harmonic_of_the_residual_is_the_maps_without_the_lights),
        cmocka_unit_test(each_harmonic_gives_its_irradiance),
        cmocka_unit_test(the_main_axis_of_two_halves_is_found),
        cmocka_unit_test(partners_are_nearest),
        cmocka_unit_test(what_is_split_has_energy_on_both_sides),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
