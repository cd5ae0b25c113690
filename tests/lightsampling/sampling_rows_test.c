/* Sampling and shading of lightsampling.h against closed forms: docs/conformance.md T10 to T12, T15, T16, T18, T20 to
   T23, T43, T73, and every BRDF and light against quadrature in double. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>
#include "conformance.h"

#ifdef LSAMP_SAMPLING_PRELUDE
#include "prelude.h"
#else
#define LSAMP_STATIC
#define LIGHTSAMPLING_IMPLEMENTATION
#include "lightsampling.h"
#endif

#define PI 3.14159265358979323846

/* ---- helpers ---- */

static uint32_t next_state = 1;
static double rnd(void)
{
    uint32_t x;
    next_state = next_state * 747796405u + 2891336453u;
    x = ((next_state >> ((next_state >> 28) + 4u)) ^ next_state) * 277803737u;
    return (double)((x >> 22 ^ x) >> 8) / 16777216.0;
}

static void check_near(const char *what, double got, double want, double tolerance)
{
    if (!(fabs(got - want) <= tolerance)) {
        print_error("%s: got %.8g, expected %.8g +- %.2g\n", what, got, want, tolerance);
        fail();
    }
}

static void check_ok(lsamp_result result)
{
    assert_int_equal(result, LSAMP_OK);
}

static void set3(float *p, double x, double y, double z)
{
    p[0] = (float)x;
    p[1] = (float)y;
    p[2] = (float)z;
}

/* Unit vector at angle theta from +Z, azimuth phi. */
static void polar(float *w, double theta, double phi)
{
    set3(w, sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta));
}

typedef struct light_box { void *memory; lsamp_light *light; uint64_t bad; } light_box;

static light_box make_light(const lsamp_light_desc *desc)
{
    light_box box;
    size_t size = lsamp_light_bytes(desc);
    assert_true(size > 0);
    box.memory = malloc(size);
    assert_non_null(box.memory);
    check_ok(lsamp_light_init(desc, box.memory, size, &box.light, &box.bad));
    return box;
}

static lsamp_light_desc light_desc(lsamp_light_kind shape, double radiance)
{
    lsamp_light_desc d;
    memset(&d, 0, sizeof d);
    d.kind = shape;
    set3(d.radiance, radiance, radiance, radiance);
    return d;
}

static lsamp_material lambert(double albedo)
{
    lsamp_material m;
    memset(&m, 0, sizeof m);
    set3(m.diffuse, albedo, albedo, albedo);
    return m;
}

typedef struct estimate { double mean[3], sd, standard_error; size_t useful; } estimate;

/* runs points that differ in their pixel only; the spread between them is the noise of one S-sample estimate. */
static estimate estimate_at(const lsamp_light *light, const lsamp_material *m, const float *p, const float *n,
                            const float *wo, lsamp_sampling sampling, uint32_t samples, uint32_t runs,
                            const float *patterns)
{
    lsamp_sample_desc d;
    lsamp_points points;
    lsamp_samples out;
    size_t total = (size_t)samples * runs, i;
    float *radiance = (float *)calloc(runs, 12);
    estimate e;
    double sum2 = 0.0;

    memset(&d, 0, sizeof d);
    memset(&points, 0, sizeof points);
    memset(&e, 0, sizeof e);
    d.sample_count = samples;
    d.sampling = sampling;
    d.seed = 7;
    d.patterns = patterns;
    points.count = runs;
    points.positions = p;
    points.normals = n;
    points.to_eye = wo;
    points.materials = m;
    /* one point for all: the strides must be 12 at least, so copies it is */
    {
        float *copy = (float *)malloc((size_t)runs * 36u);
        for (i = 0; i < runs; i++) {
            memcpy(copy + 9 * i, p, 12);
            memcpy(copy + 9 * i + 3, n, 12);
            memcpy(copy + 9 * i + 6, wo ? wo : n, 12);
        }
        points.positions = copy;
        points.normals = copy + 3;
        points.to_eye = copy + 6;
        points.position_stride = points.normal_stride = points.to_eye_stride = 36;
        out.directions = (float *)malloc(total * 12u);
        out.distances = (float *)malloc(total * 4u);
        out.coords = (float *)malloc(total * 12u);
        out.weights = (float *)malloc(total * 12u);
        check_ok(lsamp_sample(&d, light, &points, &out, &e.useful));
        for (i = 0; i < total; i++) {
            const float *w = out.directions + 3 * i, *x = out.coords + 3 * i;
            assert_true(fabsf(w[0] * w[0] + w[1] * w[1] + w[2] * w[2] - 1.0f) < 1e-4f);
            assert_true(out.distances[i] > 0.0f);
            assert_true(x[0] >= 0.0f && x[0] < 1.0f && x[1] >= 0.0f && x[1] < 1.0f && x[2] >= 0.0f && x[2] < 1.0f);
        }
        check_ok(lsamp_accumulate(runs, samples, out.weights, NULL, radiance, 12));
        free(copy);
        free(out.directions);
        free(out.distances);
        free(out.coords);
        free(out.weights);
    }
    for (i = 0; i < runs; i++) {
        int c;
        for (c = 0; c < 3; c++) e.mean[c] += (double)radiance[3 * i + (size_t)c] / runs;
    }
    for (i = 0; i < runs; i++) {
        double x = (double)radiance[3 * i + 1] - e.mean[1];
        sum2 += x * x;
    }
    e.sd = sqrt(sum2 / (runs - 1.0));
    e.standard_error = e.sd / sqrt((double)runs);
    free(radiance);
    return e;
}

/* Irradiance: pi times what a white Lambert surface returns. */
static estimate irradiance(const lsamp_light *light, const float *p, const float *n, lsamp_sampling sampling)
{
    lsamp_material white = lambert(1.0);
    estimate e = estimate_at(light, &white, p, n, NULL, sampling, 256, 400, NULL);
    int c;
    for (c = 0; c < 3; c++) e.mean[c] *= PI;
    e.sd *= PI;
    e.standard_error *= PI;
    return e;
}

/* row: of docs/conformance.md, or NULL where the same was said before */
static void check_irradiance(const char *row, const char *what, const lsamp_light_desc *desc, const float *p,
                             const float *n, double want, int brdf_too)
{
    light_box box = make_light(desc);
    int s;
    for (s = LSAMP_SAMPLING_DEFAULT; s <= LSAMP_SAMPLING_PAPER; s++) {
        estimate e;
        if (s == LSAMP_SAMPLING_BRDF && !brdf_too) continue;
        e = irradiance(box.light, p, n, (lsamp_sampling)s);
        print_message("  %-28s strategy %d: %.6f expected %.6f, sd of 256 samples %.2g\n", what, s, e.mean[1], want,
                      e.sd);
        /* 4 standard errors and the rounding of floats; nothing where it is dark */
        check_near(what, e.mean[1], want, 4.0 * e.standard_error + 1e-5 * fabs(want));
        if (s == LSAMP_SAMPLING_DEFAULT && row)
            CONFORM(row, what, want, e.mean[1], 4.0 * e.standard_error + 1e-5 * fabs(want));
    }
    free(box.memory);
}

/* ---- BRDFs ---- */

static const lsamp_lobe test_lobes[2] = {
    { { -1.0f, -1.0f, 1.0f }, 20.0f, { 0.9f, 0.8f, 0.7f } },
    { { -0.7f, -0.9f, 0.95f }, 5.0f, { 0.2f, 0.1f, 0.3f } },
};

static lsamp_material test_material(int i)
{
    lsamp_material m = lambert(0.3);
    if (i == 0) return m;
    if (i == 1 || i == 2) {
        m.kind = LSAMP_MATERIAL_PHONG;
        set3(m.specular, 0.6, 0.5, 0.4);
        m.exponent = i == 1 ? 30.0f : 1.0f;
    } else if (i == 3) {
        m.kind = LSAMP_MATERIAL_LAFORTUNE;
        m.lobes = test_lobes;
        m.lobe_count = 2;
    } else {
        m.kind = LSAMP_MATERIAL_METAL_ROUGH;
        set3(m.diffuse, 0.9, 0.6, 0.3);
        m.metallic = i == 4 ? 0.0f : i == 5 ? 1.0f : 0.5f;
        m.roughness = i == 4 ? 0.4f : i == 5 ? 0.7f : 1.0f;
    }
    return m;
}
#define MATERIALS 7

/* Midpoint rule in cos(theta) and phi about +Z. */
static void quadrature(const lsamp_material *m, const float *wo, double albedo[3], double *pdf_sum)
{
    const float n[3] = { 0.0f, 0.0f, 1.0f };
    int i, j, c;
    albedo[0] = albedo[1] = albedo[2] = *pdf_sum = 0.0;
    for (i = 0; i < 400; i++)
        for (j = 0; j < 800; j++) {
            double z = (i + 0.5) / 400.0, d = 2.0 * PI / (400.0 * 800.0);
            float wi[3], f[3], pdf;
            polar(wi, acos(z), 2.0 * PI * (j + 0.5) / 800.0);
            check_ok(lsamp_brdf_eval(m, n, NULL, wo, wi, f, &pdf));
            for (c = 0; c < 3; c++) albedo[c] += (double)f[c] * z * d;
            *pdf_sum += (double)pdf * d;
        }
}

static void samples_of_a_brdf_sum_to_its_albedo(void **state)
{
    int i, a, k, c;
    (void)state;
    for (i = 0; i < MATERIALS; i++)
        for (a = 0; a < 3; a++) {
            static const double angles[3] = { 0.1, 0.8, 1.35 };
            const float n[3] = { 0.0f, 0.0f, 1.0f };
            lsamp_material m = test_material(i);
            double albedo[3], pdf_sum, sum[3] = { 0.0, 0.0, 0.0 }, sum2 = 0.0, lost = 0.0, error;
            const int count = 1 << 16;
            float wo[3];

            polar(wo, angles[a], 0.7);
            quadrature(&m, wo, albedo, &pdf_sum);
            for (k = 0; k < count; k++) {
                float u[2], wi[3], f[3], pdf, fe[3], pe;
                u[0] = (float)rnd();
                u[1] = (float)rnd();
                check_ok(lsamp_brdf_sample(&m, n, NULL, wo, u, wi, f, &pdf));
                if (!(pdf > 0.0f)) {
                    lost += 1.0;
                    continue;
                }
                check_ok(lsamp_brdf_eval(&m, n, NULL, wo, wi, fe, &pe));
                check_near("eval at the sample", (double)pe, (double)pdf, 2e-3 * (double)pdf);
                for (c = 0; c < 3; c++) sum[c] += (double)f[c] * (double)wi[2] / (double)pdf / count;
                sum2 += pow((double)f[1] * (double)wi[2] / (double)pdf, 2.0) / count;
            }
            error = sqrt(fmax(sum2 - sum[1] * sum[1], 0.0) / count);
            print_message("  material %d angle %.2f: albedo %.4f sampled %.4f, pdf sums to %.4f, %.4f lost\n", i,
                          angles[a], albedo[1], sum[1], pdf_sum, lost / count);
            check_near("albedo", sum[1], albedo[1], 4.0 * error + 1e-3);
            check_near("pdf and lost samples", pdf_sum + lost / count, 1.0, 4.0 * sqrt(0.25 / count) * (lost > 0.0) +
                       1.5e-3);
            if (i != 3 && i != 4) assert_true(albedo[0] <= 1.0 && albedo[1] <= 1.0 && albedo[2] <= 1.0);
        }
}

static void brdfs_equal_their_closed_forms(void **state)
{
    const float n[3] = { 0.0f, 0.0f, 1.0f };
    lsamp_material m = lambert(0.5);
    double albedo[3], pdf_sum;
    float wo[3], wi[3], f[3], g[3], pdf;
    int i, k;
    (void)state;

    polar(wo, 0.4, 0.0);
    polar(wi, 1.0, 2.0);
    check_ok(lsamp_brdf_eval(&m, n, NULL, wo, wi, f, &pdf));
    check_near("Lambert", (double)f[0], 0.5 / PI, 1e-7);
    check_near("cosine density", (double)pdf, cos(1.0) / PI, 1e-6);

    /* Phong seen along the normal: its albedo is specular exactly. */
    m = test_material(1);
    quadrature(&m, n, albedo, &pdf_sum);
    check_near("Phong albedo", albedo[0], 0.3 + 0.6, 2e-3);

    /* GGX at the mirror direction: D = 1 / (pi a^2), correlated Smith in closed form. */
    m = test_material(5);
    polar(wo, 0.6, 0.0);
    polar(wi, 0.6, PI);
    check_ok(lsamp_brdf_eval(&m, n, NULL, wo, wi, f, &pdf));
    {
        double a = 0.49, c = cos(0.6), fr = 0.6 + 0.4 * pow(1.0 - c, 5.0);
        double v = 0.5 / (2.0 * c * sqrt(a * a + (1.0 - a * a) * c * c));
        check_near("GGX", (double)f[1], fr * v / (PI * a * a), 1e-5);
    }
    /* White furnace of a fully reflecting GGX: below 1, and close to it when smooth. */
    set3(m.diffuse, 1.0, 1.0, 1.0);
    m.roughness = 0.3f;
    quadrature(&m, wo, albedo, &pdf_sum);
    assert_true(albedo[0] < 1.0 && albedo[0] > 0.97);

    /* Reciprocity */
    for (i = 0; i < MATERIALS; i++)
        for (k = 0; k < 100; k++) {
            m = test_material(i);
            polar(wo, acos(0.02 + 0.97 * rnd()), 2.0 * PI * rnd());
            polar(wi, acos(0.02 + 0.97 * rnd()), 2.0 * PI * rnd());
            if (i == 3) continue;   /* its second lobe has Cx != Cy: the frame decides */
            check_ok(lsamp_brdf_eval(&m, n, NULL, wo, wi, f, &pdf));
            check_ok(lsamp_brdf_eval(&m, n, NULL, wi, wo, g, &pdf));
            check_near("reciprocity", (double)f[0], (double)g[0], 1e-4 * (double)f[0] + 1e-6);
        }
    /* with the frame given Lafortune is reciprocal too, and turning the frame and the directions changes nothing */
    for (k = 0; k < 100; k++) {
        float t[3] = { 1.0f, 0.0f, 0.0f }, t2[3], wo2[3], wi2[3];
        double a = acos(0.02 + 0.97 * rnd()), b = 6.0 * rnd(), c = acos(0.02 + 0.97 * rnd()), d = 6.0 * rnd();
        m = test_material(3);
        polar(wo, a, b);
        polar(wi, c, d);
        polar(wo2, a, b + 1.0);
        polar(wi2, c, d + 1.0);
        set3(t2, cos(1.0), sin(1.0), 0.0);
        check_ok(lsamp_brdf_eval(&m, n, t, wo, wi, f, &pdf));
        check_ok(lsamp_brdf_eval(&m, n, t, wi, wo, g, &pdf));
        check_near("Lafortune reciprocity", (double)f[0], (double)g[0], 1e-4 * (double)f[0] + 1e-6);
        check_ok(lsamp_brdf_eval(&m, n, t2, wo2, wi2, g, &pdf));
        check_near("Lafortune frame", (double)f[0], (double)g[0], 1e-4 * (double)f[0] + 1e-6);
    }
    /* below the surface */
    polar(wi, 2.0, 0.0);
    check_ok(lsamp_brdf_eval(&m, n, NULL, wo, wi, f, &pdf));
    assert_true(f[0] == 0.0f && pdf == 0.0f);
}

/* ---- environment ---- */

static lsamp_light_desc sky_desc(const float *texels, uint32_t w, uint32_t h)
{
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_ENVIRONMENT, 1.0);
    d.texels = texels;
    d.width = w;
    d.height = h;
    return d;
}

static void t10_a_uniform_sky_lights_every_normal_by_pi(void **state)
{
    static const float normals[4][3] = { { 0, 1, 0 }, { 0, 0, -1 }, { 0.6f, 0, 0.8f }, { 0, -1, 0 } };
    const float p[3] = { 1.0f, 2.0f, 3.0f };
    float texels[16 * 8 * 3];
    lsamp_light_desc plain = light_desc(LSAMP_LIGHT_DEFAULT, 1.0), mapped;
    int i;
    (void)state;

    for (i = 0; i < 16 * 8 * 3; i++) texels[i] = 1.0f;
    mapped = sky_desc(texels, 16, 8);
    for (i = 0; i < 4; i++) {
        check_irradiance(i ? NULL : "T10", "irradiance under a uniform sky", &plain, p, normals[i], PI, 1);
        check_irradiance(i ? NULL : "T10", "irradiance under a uniform map of 16 x 8", &mapped, p, normals[i], PI, 1);
    }
}

/* T11, T12: a cap of 30 degrees, half of what it would be by equal weights of the rows. */
static void t11_t12_rows_of_a_sky_count_by_solid_angle(void **state)
{
    enum { W = 24, H = 12 };
    const float p[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
    static float texels[W * H * 3];
    lsamp_light_desc d = sky_desc(texels, W, H);
    light_box box;
    double sum = 0.0, cap = 0.0;
    uint32_t y;
    (void)state;

    for (y = 0; y < 2 * W * 3; y++) texels[y] = 1.0f;   /* rows 0 and 1: theta < 30 degrees */
    box = make_light(&d);
    for (y = 0; y < H; y++) {
        /* the density of a row's texels gives their solid angle: p / pdf */
        double theta = (y + 0.5) * PI / H, from = cos(y * PI / H), to = cos((y + 1) * PI / H);
        float w[3];
        lsamp_emission e;
        set3(w, sin(theta), cos(theta), 1e-4);
        sum += 2.0 * PI * (from - to);
        if (!lsamp_light_hit(box.light, p, w, &e)) continue;
        cap += 2.0 * PI * (from - to) * (double)e.radiance[0];
        /* constant radiance: the density over the cap is 1 / its solid angle */
        check_near("T11 density", (double)e.pdf, 1.0 / (2.0 * PI * (1.0 - cos(PI / 6.0))), 1e-5);
    }
    CONFORM("T12", "solid angle of all rows, times pi", 4.0, sum / PI, 1e-12);
    CONFORM("T11", "share of a cap of 30 degrees", 0.0669873, cap / sum, 1e-6);
    free(box.memory);
    check_irradiance("T11", "irradiance under a cap of 30 degrees", &d, p, up, PI * 0.25, 1);
#ifdef LSAMP_SAMPLING_PRELUDE
    for (y = 1; y <= 3000; y += 7) {
        uint32_t k;
        for (k = 0; k <= y; k++)
            check_near("T12 row edge", lsamp__row_edge(k, y), cos(PI * k / y), 2e-15);
    }
#endif
}

static void a_ray_hits_the_texel_that_is_sampled_there(void **state)
{
    enum { W = 8, H = 4 };
    const float p[3] = { 0, 0, 0 };
    static float texels[W * H * 3];
    lsamp_light_desc d = sky_desc(texels, W, H);
    light_box box;
    lsamp_emission e;
    uint32_t i;
    int k;
    (void)state;

    for (i = 0; i < W * H * 3; i++) texels[i] = (float)(i + 1);
    d.rotation = (float)(2.0 * PI / W);     /* by one texel */
    box = make_light(&d);
    for (k = 0; k < 2000; k++) {
        double theta = acos(1.0 - 2.0 * rnd()), phi = 2.0 * PI * (rnd() - 0.5), u = 0.5 + phi / (2.0 * PI) + 1.0 / W;
        double x = (u - floor(u)) * W, y = theta / PI * H;
        float w[3];
        if (fabs(x - floor(x + 0.5)) < 1e-4 || fabs(y - floor(y + 0.5)) < 1e-4) continue;
        set3(w, sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi));
        assert_int_equal(lsamp_light_hit(box.light, p, w, &e), 1);
        assert_true(e.radiance[0] == texels[((uint32_t)y * W + (uint32_t)x) * 3u]);
        assert_true(e.distance == LSAMP_INFINITY);
        check_near("coordinate x of D", (double)e.coords[0], 0.5 + phi / (2.0 * PI), 1e-5);
        check_near("coordinate y of D", (double)e.coords[1], theta / PI, 1e-5);
    }
    /* sampled and hit agree */
    for (k = 0; k < 2000; k++) {
        float u[3];
        lsamp_emission h;
        set3(u, rnd(), rnd(), rnd());
        assert_int_equal(lsamp_light_sample(box.light, p, u, &e), 1);
        assert_int_equal(lsamp_light_hit(box.light, p, e.direction, &h), 1);
        if (h.radiance[0] != e.radiance[0]) continue;   /* on an edge between texels */
        check_near("pdf", (double)h.pdf, (double)e.pdf, 1e-6 * (double)e.pdf);
        check_near("x", (double)h.coords[0], (double)e.coords[0], 2e-5);
        check_near("y", (double)h.coords[1], (double)e.coords[1], 2e-5);
    }
    free(box.memory);
}

/* T15: never an empty texel, the range ends, chi-square of a 64 x 32 map. */
static void t15_texels_are_chosen_by_their_light(void **state)
{
    enum { W = 64, H = 32, COUNT = 1 << 20 };
    const float p[3] = { 0, 0, 0 };
    static float texels[W * H * 3];
    static double want[W * H];
    static uint32_t got[W * H];
    const float two[6] = { 0, 0, 0, 1, 1, 1 };
    const float top = 1.0f - 1.0f / 16777216.0f;
    lsamp_light_desc d = sky_desc(two, 2, 1);
    light_box box = make_light(&d);
    lsamp_emission e;
    double total = 0.0, chi = 0.0, cells = 0.0;
    uint32_t i, wrong = 0, empty = 0;
    (void)state;

    for (i = 0; i <= 1000; i++) {
        float u[3];
        set3(u, i / 1000.0 < (double)top ? i / 1000.0 : (double)top, 0.5, 0.0);
        if (i == 1000) u[0] = top;
        assert_int_equal(lsamp_light_sample(box.light, p, u, &e), 1);
        wrong += !(e.direction[2] > -1e-4f && e.radiance[0] == 1.0f);      /* the half with z > 0 */
    }
    CONFORM("T15", "samples of the empty one of two texels, u = 0 to 1 - 2^-24", 0, wrong, 0);
    free(box.memory);

    for (i = 0; i < W * H; i++) {
        double r = rnd(), L = i % 7 == 0 ? 0.0 : r * r * r * (i == 1000 ? 500.0 : 1.0);
        set3(texels + 3 * i, L, 0.5 * L, 2.0 * L);
        want[i] = L * (cos(PI * (i / W) / H) - cos(PI * (i / W + 1) / H));
        total += want[i];
    }
    d = sky_desc(texels, W, H);
    box = make_light(&d);
    for (i = 0; i < COUNT; i++) {
        float u[3];
        uint32_t x, y;
        set3(u, rnd(), rnd(), 0.0);
        assert_int_equal(lsamp_light_sample(box.light, p, u, &e), 1);
        x = (uint32_t)((double)e.coords[0] * W);
        y = (uint32_t)((double)e.coords[1] * H);
        assert_true(e.radiance[0] > 0.0f);
        if (e.radiance[0] != texels[(y * W + x) * 3u]) {     /* rounded across an edge: count it where it came from */
            if (x + 1u < W && texels[(y * W + x + 1u) * 3u] == e.radiance[0]) x++;
            else if (x > 0 && texels[(y * W + x - 1u) * 3u] == e.radiance[0]) x--;
            else if (y + 1u < H && texels[((y + 1u) * W + x) * 3u] == e.radiance[0]) y++;
            else if (y > 0 && texels[((y - 1u) * W + x) * 3u] == e.radiance[0]) y--;
        }
        got[y * W + x]++;
    }
    for (i = 0; i < W * H; i++) {
        double expected = want[i] / total * COUNT;
        if (want[i] == 0.0) empty += got[i];
        if (expected < 5.0) continue;
        chi += (got[i] - expected) * (got[i] - expected) / expected;
        cells += 1.0;
    }
    CONFORM("T15", "samples of empty texels, 64 x 32 texels, 2^20 samples", 0, empty, 0);
    /* p = 0.001 by Wilson and Hilferty */
    {
        double k = cells - 1.0, limit = k * pow(1.0 - 2.0 / (9.0 * k) + 3.09 * sqrt(2.0 / (9.0 * k)), 3.0);
        print_message("  T15 chi-square %.1f of %.0f cells, limit %.1f\n", chi, cells, limit);
        CONFORM_MAX("T15", "chi-square over its limit at p = 0.001, 64 x 32 texels, 2^20 samples", 1, chi / limit);
    }
    free(box.memory);
}

/* T16: 2^21 texels, all but one dim: the total must not stop growing. */
static void t16_one_bright_texel_of_a_large_map_keeps_its_share(void **state)
{
    enum { W = 2048, H = 1024 };
    const float p[3] = { 0, 0, 0 }, w[3] = { 0, 0, 1 };
    float *texels = (float *)malloc((size_t)W * H * 12u);
    lsamp_light_desc d = sky_desc(NULL, W, H);
    light_box box;
    lsamp_emission e;
    double solid = 2.0 * PI / W * (cos(PI * 511 / H) - cos(PI * 512 / H)), total;
    size_t i;
    (void)state;

    for (i = 0; i < (size_t)W * H * 3u; i++) texels[i] = 1.0f;
    for (i = 0; i < 3; i++) texels[(511u * W + 700u) * 3u + i] = 1e6f;
    total = 4.0 * PI + solid * (1e6 - 1.0);
    d.texels = texels;
    box = make_light(&d);
    assert_int_equal(lsamp_light_hit(box.light, p, w, &e), 1);
    CONFORM("T16", "density of a dim texel times the total of 2^21 texels, one of them 1e6", 1, (double)e.pdf * total,
            1e-6);
    free(box.memory);
    free(texels);
}

/* T18, T20, T21 */
static void t18_t20_t21_one_texel_lights_at_any_rotation(void **state)
{
    enum { W = 64, H = 32 };
    const float p[3] = { 0, 0, 0 };
    static float texels[W * H * 3];
    lsamp_light_desc d = sky_desc(texels, W, H);
    double from = cos(PI * 5 / H), to = cos(PI * 6 / H), solid = 2.0 * PI / W * (from - to);
    double y = cos(PI * 5.5 / H), want = 1000.0 * 0.5 * (from * from - to * to) * 2.0 * PI / W;
    double worst[3] = { 0.0, 0.0, 0.0 }, facing = 0.0;
    float up[3] = { 0, 1, 0 }, n[3];
    uint32_t turn, i;
    light_box box;
    estimate e;
    (void)state;

    for (i = 0; i < 256; i++) {     /* the texel by the midpoint rule, seen by a point whose normal is its centre */
        double t = from + (to - from) * (i / 16 + 0.5) / 16, x = 2.0 * PI / W * ((i % 16 + 0.5) / 16 - 0.5);
        facing += 1000.0 * solid / 256 * (t * y + sqrt((1.0 - t * t) * (1.0 - y * y)) * cos(x));
    }
    texels[(5 * W + 0) * 3] = 1000.0f;      /* red only, beside the seam */
    check_irradiance("T18", "green of a red texel", &d, p, up, 0.0, 0);
    for (turn = 0; turn < W; turn += 9) {   /* T21: texel and rotation cancel */
        memset(texels, 0, sizeof texels);
        texels[(5 * W + turn) * 3] = 1000.0f;
        d.rotation = (float)(2.0 * PI * turn / W);
        box = make_light(&d);
        e = irradiance(box.light, p, up, LSAMP_SAMPLING_DEFAULT);
        /* BRDF samples bring p_brdf / (p_brdf + p_light) = 0.0013 of it, by 69 hits on average of 51,200: +- 12 % of
           that are 1.6e-4 of all, four times that 6.5e-4 */
        worst[0] = fmax(worst[0], fabs(e.mean[0] / want - 1.0));
        assert_true(e.mean[1] == 0.0 && e.mean[2] == 0.0);     /* T18 */
        e = irradiance(box.light, p, up, LSAMP_SAMPLING_LIGHT);
        worst[1] = fmax(worst[1], fabs(e.mean[0] / want - 1.0));
        assert_true(e.mean[1] == 0.0 && e.mean[2] == 0.0);
        set3(n, -sqrt(1.0 - y * y) * cos(PI / W), y, -sqrt(1.0 - y * y) * sin(PI / W));
        e = irradiance(box.light, p, n, LSAMP_SAMPLING_LIGHT);
        worst[2] = fmax(worst[2], fabs(e.mean[0] / facing - 1.0));
        free(box.memory);
    }
    CONFORM("T21", "largest relative error of a texel at any rotation, by both strategies", 0, worst[0], 6.5e-4);
    CONFORM("T20", "largest relative error of one texel's irradiance, by the light", 0, worst[1], 1e-5); /* floats */
    CONFORM("T20", "largest relative error of one texel's irradiance, faced", 0, worst[2], 1e-5);
}

/* T22 */
static void t22_bad_texels_are_counted_and_black(void **state)
{
    const float p[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
    static float texels[8 * 4 * 3];
    lsamp_light_desc d = sky_desc(texels, 8, 4);
    light_box box;
    estimate e;
    int i;
    (void)state;

    for (i = 0; i < 96; i++) texels[i] = 1.0f;
    texels[0] = NAN;
    texels[1] = INFINITY;
    texels[10] = -1.0f;
    texels[20] = -INFINITY;
    box = make_light(&d);
    CONFORM("T22", "texels with NaN, infinity or below 0 counted, of 32", 3, box.bad, 0);
    e = irradiance(box.light, p, up, LSAMP_SAMPLING_DEFAULT);
    assert_true(e.mean[0] < PI && e.mean[0] > 0.8 * PI && e.mean[2] < PI);
    free(box.memory);
    for (i = 0; i < 96; i++) texels[i] = NAN;   /* nothing left: black, not an error */
    box = make_light(&d);
    assert_true(box.bad == 32);
    e = irradiance(box.light, p, up, LSAMP_SAMPLING_DEFAULT);
    assert_true(e.mean[0] == 0.0 && e.useful == 0);
    free(box.memory);
    for (i = 0; i < 96; i++) texels[i] = 3e38f;  /* sums beyond the float range */
    box = make_light(&d);
    assert_true(box.bad == 0);
    free(box.memory);
}

/* T23: a wall to the height of the sky hides one half: pi / 2; a roof all of it. Visibility is the user's. */
static void t23_a_wall_hides_half_of_the_sky_and_a_roof_all(void **state)
{
    enum { S = 4096 };
    static float w[S * 3], distance[S], weights[S * 3], visibility[S];
    const float p[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_DEFAULT, 1.0);
    lsamp_material white = lambert(1.0);
    lsamp_sample_desc desc;
    lsamp_points points;
    lsamp_samples out;
    light_box box = make_light(&d);
    float radiance[3] = { 0, 0, 0 };
    int i;
    (void)state;

    memset(&desc, 0, sizeof desc);
    memset(&points, 0, sizeof points);
    desc.sample_count = S;
    points.count = 1;
    points.positions = p;
    points.normals = up;
    points.position_stride = points.normal_stride = 12;
    points.materials = &white;
    out.directions = w;
    out.distances = distance;
    out.weights = weights;
    out.coords = NULL;
    check_ok(lsamp_sample(&desc, box.light, &points, &out, NULL));
    for (i = 0; i < S; i++) visibility[i] = w[3 * i] > 0.0f ? 1.0f : 0.0f;
    check_ok(lsamp_accumulate(1, S, weights, visibility, radiance, 12));
    CONFORM("T23", "irradiance at the foot of an endless wall", PI / 2.0, (double)radiance[0] * PI, PI / 200.0);
    set3(radiance, 0, 0, 0);
    for (i = 0; i < S; i++) visibility[i] = w[3 * i + 1] > 0.0f ? 0.0f : 1.0f;
    check_ok(lsamp_accumulate(1, S, weights, visibility, radiance, 12));
    CONFORM("T23", "irradiance under an endless roof", 0, radiance[0], 0);
    free(box.memory);
}

/* ---- local lights ---- */

static void t43_a_rectangle_lights_as_in_closed_form(void **state)
{
    const float up[3] = { 0, 0, 1 }, centre[3] = { 0.5f, 0.5f, 0.0f }, corner[3] = { 0, 0, 0 };
    const float far_off[3] = { 40.0f, 30.0f, 0.0f }, tilt[3] = { 0.6f, 0.0f, 0.8f };
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_RECTANGLE, 1.0), sheared;
    double want = 0.0;
    int i, j;
    (void)state;

    /* unit square at height 1 that emits downwards: u x v = -Z */
    set3(d.position, 0, 0, 1);
    set3(d.u, 0, 1, 0);
    set3(d.v, 1, 0, 0);
    check_irradiance("T43", "irradiance, unit square above the point", &d, centre, up, PI * 0.23945647, 1);
    check_irradiance("T43", "irradiance, unit square with a corner above the point", &d, corner, up, PI * 0.138532, 1);
    d.cosine_power = 2.0f;
    for (i = 0; i < 1000; i++)
        for (j = 0; j < 1000; j++) {
            double x = (i + 0.5) / 1000.0 - 0.5, y = (j + 0.5) / 1000.0 - 0.5, d2 = x * x + y * y + 1.0;
            want += 1e-6 / (d2 * d2) / d2;
        }
    check_irradiance("T43", "irradiance, unit square above the point, emission cos^2", &d, centre, up, want, 1);
    d.cosine_power = 0.0f;
    want = 0.0;
    for (i = 0; i < 400; i++)
        for (j = 0; j < 400; j++) {
            double x = (i + 0.5) / 400.0 - 40.0, y = (j + 0.5) / 400.0 - 30.0, d2 = x * x + y * y + 1.0;
            want += 1.0 / (d2 * d2) / 160000.0;
        }
    check_irradiance("irradiance", "unit square far off, sampled by area", &d, far_off, up, want, 0);
    /* behind it: dark */
    {
        const float above[3] = { 0.5f, 0.5f, 2.0f }, down[3] = { 0, 0, -1 };
        check_irradiance("irradiance", "behind a one-sided square", &d, above, down, 0.0, 1);
    }
    /* tilted receiver, and the same light as a parallelogram */
    sheared = d;
    set3(sheared.u, 0.5, 1, 0);
    want = 0.0;
    for (i = 0; i < 1000; i++)
        for (j = 0; j < 1000; j++) {
            double s = (i + 0.5) / 1000.0, t = (j + 0.5) / 1000.0, x = t + 0.5 * s - 0.5, y = s - 0.5;
            double d2 = x * x + y * y + 1.0, c = 0.6 * x + 0.8;
            want += (c > 0.0 ? c : 0.0) / (d2 * d2) * 1e-6;
        }
    check_irradiance("irradiance", "parallelogram above a tilted point", &sheared, centre, tilt, want, 1);
    /* a hundredth as large: what counts as a right angle does not depend on the scale */
    {
        const float small[3] = { 0.005f, 0.005f, 0.0f };
        set3(sheared.position, 0, 0, 0.01);
        set3(sheared.u, 0.005, 0.01, 0);
        set3(sheared.v, 0.01, 0, 0);
        check_irradiance(NULL, "small parallelogram above a tilted point", &sheared, small, tilt, want, 1);
    }
}

static void a_disc_lights_as_in_closed_form(void **state)
{
    const float p[3] = { 0, 0, 0 }, up[3] = { 0, 0, 1 };
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_DISC, 2.0);
    (void)state;

    set3(d.position, 0, 0, 1);
    set3(d.direction, 0, 0, -1);
    d.radius = 1.0f;
    check_irradiance("irradiance", "disc of radius 1 and L 2, 1 above", &d, p, up, 2.0 * PI * 0.5,
                     1); /* pi L r^2 / (r^2 + h^2) */
    d.radius = 3.0f;
    check_irradiance("irradiance", "disc of radius 3 and L 2, 1 above", &d, p, up, 2.0 * PI * 0.9, 1);
    d.radius = 0.05f;
    check_irradiance("irradiance", "disc of radius 0.05 and L 2, 1 above", &d, p, up, 2.0 * PI * 0.0025 / 1.0025, 0);
    /* off axis: closed form of the disc parallel to the receiver at lateral distance a */
    {
        const float side[3] = { 1.5f, 0, 0 };
        double h2 = 1.0, a2 = 2.25, r2 = 1.0, k = a2 + h2 + r2;
        d.radius = 1.0f;
        check_irradiance("irradiance", "disc of radius 1 and L 2, off its axis by 1.5", &d, side, up,
                         2.0 * PI * 0.5 * (1.0 - (h2 + a2 - r2) / sqrt(k * k - 4.0 * a2 * r2)), 1);
    }
}

static void t73_a_sphere_lights_as_in_closed_form(void **state)
{
    static const double far[4] = { 1.25, 2.0, 8.0, 20.0 };
    const float up[3] = { 0, 0, 1 };
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_SPHERE, 1.0);
    int i;
    (void)state;

    d.radius = 1.0f;
    for (i = 0; i < 4; i++) {
        const float tilt[3] = { 0.6f, 0, 0.8f };
        float p[3];
        set3(p, 0, 0, -far[i]);
        char what[2][80];
        snprintf(what[0], sizeof what[0], "irradiance facing a sphere %g r away", far[i]);
        snprintf(what[1], sizeof what[1], "irradiance of a point tilted against a sphere %g r away", far[i]);
        check_irradiance("T73", what[0], &d, p, up, PI / (far[i] * far[i]), i < 3);
        /* whole sphere above the horizon: times the cosine */
        if (far[i] > 1.7) check_irradiance("T73", what[1], &d, p, tilt, 0.8 * PI / (far[i] * far[i]), i < 3);
    }
    {
        const float inside[3] = { 0.1f, 0, 0 };
        check_irradiance("irradiance", "inside of a sphere light", &d, inside, up, 0.0, 1);
    }
}

/* A line of length 2 a above a point at height h, thin: E = 2 r L (a / (a^2 + h^2) + atan(a / h) / h). */
static void a_thin_line_lights_as_in_closed_form(void **state)
{
    const float p[3] = { 0, 0, 0 }, up[3] = { 0, 0, 1 };
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_LINE, 3.0);
    double a = 1.5, h = 0.7, r = 1e-5;
    (void)state;

    set3(d.position, -a, 0, h);
    set3(d.u, 2.0 * a, 0, 0);
    d.radius = (float)r;
    check_irradiance("irradiance", "thin line of length 3, radius 1e-5, L 3, 0.7 above", &d, p, up,
                     2.0 * r * 3.0 * (a / (a * a + h * h) + atan(a / h) / h), 0);
}

/* A cylinder so long that it is infinite: as its cross-section, E = pi L r / d facing it. */
static void a_thick_line_lights_as_its_cross_section(void **state)
{
    const float p[3] = { 0, 0, 0 }, up[3] = { 0, 0, 1 };
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_LINE, 1.0);
    (void)state;

    set3(d.position, -30, 0, 2);
    set3(d.u, 60, 0, 0);
    d.radius = 0.8f;
    check_irradiance("irradiance", "endless cylinder of radius 0.8, axis 2 above", &d, p, up, PI * 0.8 / 2.0, 1);
}

static void suns_points_and_spots_light_as_in_closed_form(void **state)
{
    const float p[3] = { 1.0f, 0, 0 }, up[3] = { 0, 0, 1 };
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_SUN, 2.0);
    (void)state;

    set3(d.direction, 0.6, 0, 0.8);
    check_irradiance("irradiance", "sun of E 2, cosine 0.8", &d, p, up, 1.6, 0);
    d = light_desc(LSAMP_LIGHT_POINT, 5.0);
    set3(d.position, 1, 0, 2);
    check_irradiance("irradiance", "point light of I 5, 2 above", &d, p, up, 1.25, 0);
    set3(d.position, 4, 0, 4);
    check_irradiance("irradiance", "point light of I 5, 5 away, cosine 0.8", &d, p, up, 5.0 / 25.0 * 0.8, 0);
    d.kind = LSAMP_LIGHT_SPOT;
    set3(d.direction, 0, 0, -1);
    d.cone_half_angle = (float)(atan(0.75) + 0.01);
    check_irradiance("irradiance", "spot of I 5, 5 away, cosine 0.8", &d, p, up, 5.0 / 25.0 * 0.8, 0);
    d.cone_half_angle = (float)(atan(0.75) - 0.01);
    check_irradiance("irradiance", "spot, outside of its cone", &d, p, up, 0.0, 0);
}

/* The textured versions of every shape: half bright, a quarter black; the sum of both halves is the whole. */
static void parts_of_a_texture_light_as_the_whole(void **state)
{
    static const float texels[2][12] = { { 4, 4, 4, 0, 0, 0, 0, 0, 0, 1, 1, 1 },
                                         { 0, 0, 0, 4, 4, 4, 4, 4, 4, 3, 3, 3 } };
    const float p[3] = { 0.1f, -0.2f, 0 }, up[3] = { 0, 0, 1 };
    int shape, s, k;
    (void)state;

    for (shape = LSAMP_LIGHT_LINE; shape <= LSAMP_LIGHT_SPHERE; shape++) {
        lsamp_light_desc d = light_desc((lsamp_light_kind)shape, 0.5);
        set3(d.position, -0.5, -0.5, 2);
        set3(d.u, shape == LSAMP_LIGHT_LINE ? 2.0 : 0.0, shape == LSAMP_LIGHT_LINE ? 0.0 : 1.3, 0);
        set3(d.v, 1.1, 0, 0);
        set3(d.direction, 0, 0, -1);
        d.radius = shape == LSAMP_LIGHT_LINE ? 0.2f : 0.7f;
        for (s = LSAMP_SAMPLING_DEFAULT; s <= LSAMP_SAMPLING_BRDF; s++) {
            estimate whole, part, other;
            light_box box;
            lsamp_light_desc t = d;

            set3(t.radiance, 2, 2, 2);      /* 4 units of 0.5 */
            box = make_light(&t);
            whole = irradiance(box.light, p, up, (lsamp_sampling)s);
            free(box.memory);
            t = d;
            t.width = shape == LSAMP_LIGHT_LINE ? 4 : 2;
            t.height = shape == LSAMP_LIGHT_LINE ? 1 : 2;
            t.texels = texels[0];
            box = make_light(&t);
            part = irradiance(box.light, p, up, (lsamp_sampling)s);
            /* sampled and hit agree in every field */
            for (k = 0; k < 500; k++) {
                lsamp_emission a, b;
                float u[3];
                set3(u, rnd(), rnd(), rnd());
                if (!lsamp_light_sample(box.light, p, u, &a)) continue;
                if (!lsamp_light_hit(box.light, p, a.direction, &b)) continue;     /* the rim */
                if (a.radiance[0] != b.radiance[0]) continue;
                /* pdf ~ 1 / cosine, and a hit point's cosine^2 carries the rounding of its discriminant, about 1e-6
                   absolute: at the sphere's rim 1 / pdf^2 is known that well, and not better */
                if ((double)a.pdf < 300.0)
                    check_near("pdf", (double)b.pdf, (double)a.pdf, 0.03 * (double)a.pdf);
                check_near("1 / pdf^2", 1.0 / pow((double)b.pdf, 2.0), 1.0 / pow((double)a.pdf, 2.0),
                           0.06 / pow((double)a.pdf, 2.0) + 1e-6);
                check_near("distance", (double)b.distance, (double)a.distance, 2e-3);
                check_near("x", (double)b.coords[0], (double)a.coords[0], 3e-3);
                check_near("y", (double)b.coords[1], (double)a.coords[1], 3e-3);
            }
            free(box.memory);
            t.texels = texels[1];
            box = make_light(&t);
            other = irradiance(box.light, p, up, (lsamp_sampling)s);
            free(box.memory);
            print_message("  textured shape %d strategy %d: %.5f + %.5f = %.5f, sd %.2g\n", shape, s, part.mean[1],
                          other.mean[1], whole.mean[1], part.sd);
            check_near("sum of parts", part.mean[1] + other.mean[1], whole.mean[1],
                       4.0 * sqrt(part.standard_error * part.standard_error + other.standard_error *
                                  other.standard_error + whole.standard_error * whole.standard_error) + 1e-5);
            assert_true(part.mean[1] > 0.1 * whole.mean[1]);
        }
    }
}

/* D at the coordinates of a sample is the sample. */
static void coordinates_in_a_domain_give_the_sample_back(void **state)
{
    static const lsamp_domain_kind kinds[9] = {
        LSAMP_DOMAIN_LATLONG, LSAMP_DOMAIN_LATLONG, LSAMP_DOMAIN_LATLONG, LSAMP_DOMAIN_LIST, LSAMP_DOMAIN_LIST,
        LSAMP_DOMAIN_LINE, LSAMP_DOMAIN_RECTANGLE, LSAMP_DOMAIN_DISC, LSAMP_DOMAIN_SPHERE
    };
    const float p[3] = { 0.3f, -0.2f, 0.1f };
    int shape, k, i;
    (void)state;

    for (shape = LSAMP_LIGHT_DEFAULT; shape <= LSAMP_LIGHT_SPHERE; shape++) {
        lsamp_light_desc d = light_desc((lsamp_light_kind)shape, 1.0);
        lsamp_domain domain;
        light_box box;

        set3(d.position, -0.5, -0.5, 2);
        set3(d.u, 0, 1.3, 0);
        set3(d.v, 1.1, 0, 0);
        set3(d.direction, 0, 0, shape == LSAMP_LIGHT_SUN ? 1 : -1);
        d.radius = shape == LSAMP_LIGHT_LINE ? 1e-4f : 0.7f;
        d.cone_half_angle = 1.0f;
        box = make_light(&d);
        check_ok(lsamp_light_domain(box.light, &domain));
        assert_int_equal(domain.kind, kinds[shape]);
        for (k = 0; k < 300; k++) {
            double s, t, x = 0.0, y = 0.0, at[3] = { 0.0, 0.0, 0.0 }, phi, ring;
            lsamp_emission e;
            float u[3];

            set3(u, rnd(), rnd(), rnd());
            assert_int_equal(lsamp_light_sample(box.light, p, u, &e), 1);
            s = (double)e.coords[0];
            t = (double)e.coords[1];
            phi = 2.0 * PI * (s - 0.5);
            ring = sqrt(1.0 - (1.0 - 2.0 * t) * (1.0 - 2.0 * t));
            if (domain.kind == LSAMP_DOMAIN_DISC) {
                double a = 2.0 * s - 1.0, b = 2.0 * t - 1.0;
                x = fabs(a) > fabs(b) ? a * cos(PI / 4.0 * b / a) : b * sin(PI / 4.0 * a / b);
                y = fabs(a) > fabs(b) ? a * sin(PI / 4.0 * b / a) : b * cos(PI / 4.0 * a / b);
            } else if (domain.kind == LSAMP_DOMAIN_RECTANGLE || domain.kind == LSAMP_DOMAIN_LINE) {
                x = s;
                y = t;
            }
            for (i = 0; i < 3; i++)
                at[i] = (double)domain.origin[i] + x * (double)domain.u[i] + y * (double)domain.v[i];
            if (domain.kind == LSAMP_DOMAIN_SPHERE) {
                at[0] = (double)domain.origin[0] + (double)domain.u[0] * ring * cos(phi);
                at[1] = (double)domain.origin[1] + (double)domain.u[0] * (1.0 - 2.0 * t);
                at[2] = (double)domain.origin[2] + (double)domain.u[0] * ring * sin(phi);
            }
            if (domain.kind == LSAMP_DOMAIN_LIST) {
                assert_true(domain.location_count == 1 && domain.locations[3] == 1.0f);
                for (i = 0; i < 3; i++) at[i] = (double)domain.locations[i];
            }
            if (shape <= LSAMP_LIGHT_ENVIRONMENT) {
                check_near("sky x", (double)e.direction[0], sin(PI * t) * cos(phi), 3e-4);
                check_near("sky y", (double)e.direction[1], cos(PI * t), 3e-4);
            } else if (shape > LSAMP_LIGHT_SUN) {
                for (i = 0; i < 3; i++)
                    check_near("location", at[i], (double)p[i] + (double)e.distance * (double)e.direction[i], 3e-4);
            }
        }
        free(box.memory);
    }
}

/* time: frames of 2 x 1 texels, linear between them */
static void radiance_is_linear_between_frames(void **state)
{
    static const float frames[3 * 6] = { 1, 1, 1, 1, 1, 1, 3, 3, 3, 3, 3, 3, 0, 0, 0, 0, 0, 0 };
    static const double times[6] = { 0.0, 0.25, 0.5, 1.25, 10.0, -1.0 };
    static const double held[6] = { 1.0, 2.0, 3.0, 0.0, 0.0, 1.0 }, looped[6] = { 1, 2, 3, 0.5, 0.0, 3.0 - 2.0 * 0.5 };
    const float p[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
    int i, loop;
    (void)state;

    for (loop = 0; loop < 2; loop++)
        for (i = 0; i < 6; i++) {
            lsamp_light_desc d = sky_desc(frames, 2, 1);
            light_box box;
            lsamp_emission e;
            double want = loop ? looped[i] : held[i];

            d.frame_count = 3;
            d.frames_per_second = 2.0f;
            d.loop = loop;
            d.time = (float)times[i];
            if (loop && i == 4) want = 0.0;     /* 20 frames: 20 mod 3 = 2 */
            if (loop && i == 5) want = 3.0;     /* -2 mod 3 = 1 */
            box = make_light(&d);
            if (lsamp_light_hit(box.light, p, up, &e)) check_near("time", (double)e.radiance[0], want, 1e-6);
            else check_near("time", 0.0, want, 1e-6);
            free(box.memory);
        }
}

/* A volume of points as a callback: the solid ball of radius r with emission rho / (4 pi) I; outside it lights like its
   centre. And a triangle given by its area. */
static void ball(void *user, float time, const float x[3], float position[3], float normal[3], float *area)
{
    double z = 1.0 - 2.0 * (double)x[1], s = sqrt(1.0 - z * z), r = cbrt((double)x[2]) * 0.5;
    (void)user;
    set3(position, r * s * cos(2.0 * PI * (double)x[0]), r * s * sin(2.0 * PI * (double)x[0]),
         2.0 + r * z + (double)time);
    set3(normal, 0, 0, 0);
    *area = (float)(4.0 / 3.0 * PI * 0.125);
}

static void triangle(void *user, float time, const float x[3], float position[3], float normal[3], float *area)
{
    double s = sqrt((double)x[0]), a = s * (double)x[1], b = 1.0 - s;
    (void)user;
    (void)time;
    set3(position, a, b, 1.0);
    set3(normal, 0, 0, -1);
    *area = 0.5f;
}

static void striped(void *user, float time, const float x[3], const float direction[3], float rgb[3])
{
    (void)time;
    (void)direction;
    ++*(int *)user;
    rgb[0] = x[0] < 0.25f ? 1.0f : 0.0f;
    rgb[1] = 2.0f;
    rgb[2] = NAN;
}

static void shapes_and_emission_by_callback_light_as_in_closed_form(void **state)
{
    const float p[3] = { 0, 0, 0 }, up[3] = { 0, 0, 1 }, centre[3] = { 0.5f, 0.5f, 0 };
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_CALLBACK, 1.0), t;
    light_box box;
    estimate a, b;
    int calls = 0;
    (void)state;

    /* the emission per volume towards a point of the plane z = 0: the field of the ball is not exactly that of its
       centre under the cosine, but 1/d^2 times cosine is harmonic (z/d^3), so here it is */
    d.shape_fn = ball;
    check_irradiance("irradiance", "ball of emitting points by callback", &d, p, up, 4.0 / 3.0 * PI * 0.125 / 4.0, 0);
    d.time = 1.0f;
    check_irradiance("irradiance", "ball by callback, moved by time", &d, p, up, 4.0 / 3.0 * PI * 0.125 / 9.0, 0);
    /* the diagonal halves the square: same irradiance above its middle */
    d.shape_fn = triangle;
    check_irradiance("irradiance", "half of the unit square by callback", &d, centre, up, PI * 0.23945647 / 2.0, 0);

    /* emission: a quarter of the square in red, twice the green */
    t = light_desc(LSAMP_LIGHT_RECTANGLE, 1.0);
    set3(t.position, 0, 0, 1);
    set3(t.u, 0, 1, 0);
    set3(t.v, 1, 0, 0);
    box = make_light(&t);
    a = irradiance(box.light, centre, up, LSAMP_SAMPLING_DEFAULT);
    free(box.memory);
    t.emission_fn = striped;
    t.user = &calls;
    box = make_light(&t);
    b = irradiance(box.light, centre, up, LSAMP_SAMPLING_DEFAULT);
    free(box.memory);
    check_near("emission callback", b.mean[1], 2.0 * a.mean[1], 5.0 * b.standard_error + 2.0 * a.standard_error);
    assert_true(b.mean[0] > 0.2 * a.mean[0] && b.mean[0] < 0.25 * a.mean[0] && b.mean[2] == 0.0 && calls > 0);
}

/* A box of 1 x 2 x 3 about the origin, turned out; two more triangles, not finite and without area, emit nothing. */
enum { BOX_TRIANGLES = 14, PLACES = 600 };

static void box_triangles(float *to)
{
    static const double half[3] = { 0.5, 1.0, 1.5 };
    int axis, side, t, k;
    for (axis = 0; axis < 3; axis++)
        for (side = 0; side < 2; side++)
            for (t = 0; t < 2; t++)
                for (k = 0; k < 3; k++, to += 3) {
                    int turn = side ? k : 2 - k, corner = t ? (turn + 2) % 4 : turn;
                    int u = (axis + 1) % 3, v = (axis + 2) % 3;
                    to[axis] = (float)(side ? half[axis] : -half[axis]);
                    to[u] = (float)(corner == 1 || corner == 2 ? half[u] : -half[u]);
                    to[v] = (float)(corner >= 2 ? half[v] : -half[v]);
                }
    for (k = 0; k < 18; k++) to[k] = k == 4 ? NAN : k < 9 ? 0.1f * (float)k : 0.2f;
}

static void a_mesh_lights_as_the_rectangle_that_it_is(void **state)
{
    static float box_corners[9 * BOX_TRIANGLES];
    static float pieces[9 * (BOX_TRIANGLES + 4 * PLACES + 1)];
    static const float square[18] = { 0, 0, 1, 0, 1, 1, 1, 1, 1, 0, 0, 1, 1, 1, 1, 1, 0, 1 };
    const float centre[3] = { 0.5f, 0.5f, 0 }, up[3] = { 0, 0, 1 }, corner[3] = { 0, 0, 0 };
    lsamp_mesh mesh = { square, 6, 0, NULL, 0, NULL };
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_MESH, 1.0), bad;
    lsamp_light *light = NULL;
    lsamp_domain domain;
    light_box box;
    double area = 0.0, steps = 0.0;
    int on[3] = { 0, 0, 0 }, calls = 0, k;
    size_t i, count;
    (void)state;

    /* the square of the rectangle's rows, by its two triangles, facing down */
    d.mesh = &mesh;
    check_irradiance("irradiance", "unit square 1 above its middle, as a mesh", &d, centre, up, PI * 0.23945647, 0);
    check_irradiance("irradiance", "unit square 1 above a corner, as a mesh", &d, corner, up, PI * 0.13853161, 0);
    d.emission_fn = striped;                     /* with a user of its own */
    d.user = &calls;
    box = make_light(&d);
    assert_true(irradiance(box.light, centre, up, LSAMP_SAMPLING_DEFAULT).mean[1] > 0.0 && calls > 0);
    free(box.memory);
    d.emission_fn = NULL;

    box_triangles(box_corners);
    mesh.positions = box_corners;
    mesh.vertex_count = 3 * BOX_TRIANGLES;
    d.place_count = PLACES;
    d.radius = 0.25f;
    box = make_light(&d);
    count = lsamp_light_triangles(box.light, NULL);
    assert_true(count >= 2 * PLACES && count <= BOX_TRIANGLES + 4 * PLACES);
    assert_int_equal(lsamp_light_triangles(box.light, pieces), count);
    for (i = 0; i < count; i++) {                /* no piece above half a place's share, none lost */
        const float *v = pieces + 9 * i;
        double e[2][3], n[3], one;
        for (k = 0; k < 6; k++) e[k / 3][k % 3] = (double)v[3 + k] - (double)v[k % 3];
        for (k = 0; k < 3; k++) n[k] = e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
        one = 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        assert_true(one < 22.0 / (2 * PLACES) * 1.0001);
        area += one;
    }
    check_near("area of the pieces of a box", area, 22.0, 1e-4);
    assert_int_equal(lsamp_light_domain(box.light, &domain), LSAMP_OK);
    assert_true(domain.kind == LSAMP_DOMAIN_TABLE && domain.side[0] == PLACES && domain.location_count == PLACES);
    for (i = 0; i < PLACES; i++) {               /* off one face by the radius; as many on each as its area says */
        const float *p = domain.locations + 4 * i;
        double step = 0.0;
        int faces = 0;
        assert_true(p[3] == 1.0f);
        for (k = 0; k < 3; k++)
            if (fabs(fabs((double)p[k]) - 0.5 * (k + 1) - 0.25) < 1e-5) on[k]++, faces++;
        assert_int_equal(faces, 1);
        for (k = 0; k < 3 && i; k++) step += pow((double)p[k] - (double)p[k - 4], 2);
        steps += sqrt(step) / (PLACES - 1);
    }
    for (k = 0; k < 3; k++) check_near("places on two faces", on[k], PLACES * 12.0 / (k + 1) / 22.0, 2.0);
    /* a square of a place's area has sides of 0.19: along the curve the next place is about as far */
    assert_true(steps > 0.1 && steps < 0.4);
    free(box.memory);

    bad = d, bad.mesh = NULL;
    assert_true(lsamp_light_bytes(&bad) == 0);
    bad = d, bad.place_count = (1u << 24) + 1u;
    assert_true(lsamp_light_bytes(&bad) == 0);
    bad = d, bad.radius = -1.0f;
    assert_true(lsamp_light_bytes(&bad) == 0);
    bad = d, bad.texels = up, bad.width = bad.height = 1;
    assert_true(lsamp_light_bytes(&bad) == 0);
    mesh.vertex_count = 4;
    assert_true(lsamp_light_bytes(&d) == 0);
    mesh.positions = box_corners + 9 * (BOX_TRIANGLES - 2);     /* neither triangle emits */
    mesh.vertex_count = 6;
    box.memory = malloc(lsamp_light_bytes(&d));
    assert_non_null(box.memory);
    assert_int_equal(lsamp_light_init(&d, box.memory, lsamp_light_bytes(&d), &light, NULL), LSAMP_ERR_INPUT);
    assert_null(light);
    free(box.memory);
    d = light_desc(LSAMP_LIGHT_SPHERE, 1.0);
    d.radius = 1.0f;
    box = make_light(&d);
    assert_int_equal(lsamp_light_triangles(box.light, NULL), 0);
    assert_int_equal(lsamp_light_triangles(NULL, NULL), 0);
    free(box.memory);
}

/* ---- strategies ---- */

static void every_strategy_has_the_same_mean(void **state)
{
    static float sky[64 * 32 * 3];
    const float p[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
    int i, k, s;
    (void)state;

    for (i = 0; i < 64 * 32; i++) set3(sky + 3 * i, 0.2 + rnd(), 0.2 + rnd(), 0.2 + rnd());
    set3(sky + 3 * (9 * 64 + 44), 900, 800, 700);
    for (k = 0; k < 3; k++)
        for (i = 0; i < MATERIALS; i++) {
            lsamp_material m = test_material(i);
            lsamp_light_desc d = sky_desc(sky, 64, 32);
            light_box box;
            estimate e[4];
            float wo[3];

            if (k) {
                d = light_desc(LSAMP_LIGHT_RECTANGLE, 1.0);
                set3(d.position, -0.5 - k, 1, -0.5);
                set3(d.v, k == 1 ? 1 : 4, 0, 0);
                set3(d.u, 0, 0, k == 1 ? 1 : 4);
                if (k == 2) set3(d.position, -2, 1, -2);
                memcpy(d.v, d.u, 12);
                set3(d.u, k == 1 ? 1 : 4, 0, 0);
            }
            set3(wo, sin(0.7), cos(0.7), 0);
            box = make_light(&d);
            for (s = 0; s < 4; s++) {
                e[s] = estimate_at(box.light, &m, p, up, wo, (lsamp_sampling)s, 64, 2000, NULL);
                print_message("  light %d material %d strategy %d: %.5f +- %.5f, sd of 64 %.4f, useful %.3f\n", k, i, s,
                              e[s].mean[1], e[s].standard_error, e[s].sd, (double)e[s].useful / 128000.0);
                check_near("strategy against MIS", e[s].mean[1], e[0].mean[1],
                           4.0 * sqrt(e[s].standard_error * e[s].standard_error + e[0].standard_error *
                                      e[0].standard_error) + 1e-4 * e[0].mean[1]);
            }
            free(box.memory);
        }
}

/* Rough metal under a wide disc and a wide rectangle: either strategy alone misses what the other finds. */
static void both_strategies_together_vary_less_than_either(void **state)
{
    const float p[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
    lsamp_material m = lambert(0.5);
    float wo[3];
    int s, k;
    (void)state;

    m.kind = LSAMP_MATERIAL_METAL_ROUGH;
    m.metallic = 1.0f;
    m.roughness = 0.6f;
    set3(wo, sin(0.7), cos(0.7), 0);
    for (k = 0; k < 2; k++) {
        lsamp_light_desc d = light_desc(k ? LSAMP_LIGHT_RECTANGLE : LSAMP_LIGHT_DISC, 1.0);
        light_box box;
        estimate e[3];

        set3(d.position, k ? -3.3 : -0.8, 1, k ? -2.5 : 0.0);
        set3(d.direction, 0, -1, 0);
        d.radius = 2.5f;
        set3(d.u, 5, 0, 0);
        set3(d.v, 0, 0, 5);
        box = make_light(&d);
        for (s = 0; s < 3; s++) e[s] = estimate_at(box.light, &m, p, up, wo, (lsamp_sampling)s, 64, 2000, NULL);
        print_message("  sd of 64: MIS %.4f, light %.4f, BRDF %.4f\n", e[0].sd, e[1].sd, e[2].sd);
        assert_true(e[0].sd < e[1].sd && e[0].sd < e[2].sd);
        free(box.memory);
    }
}

/* ---- patterns, frames, bad input ---- */

static void patterns_lie_in_the_square_and_differ_by_seed(void **state)
{
    static const uint32_t lengths[6] = { 1, 7, 16, 64, 100, 256 };
    int l;
    (void)state;

    assert_true(lsamp_patterns_bytes(0) == 0 && lsamp_patterns_bytes(65537) == 0);
    for (l = 0; l < 6; l++) {
        uint32_t n = lengths[l], j, k, root = (uint32_t)(sqrt((double)n) + 0.5);
        size_t size = lsamp_patterns_bytes(n);
        float *a = (float *)malloc(size), *b = (float *)malloc(size);
        unsigned char *seen = (unsigned char *)malloc(n);

        assert_true(size == 256u * n * 8u);
        check_ok(lsamp_patterns_build(n, 5, a, size));
        check_ok(lsamp_patterns_build(n, 6, b, size));
        assert_int_equal(lsamp_patterns_build(n, 6, b, size - 1u), LSAMP_ERR_MEMORY);
        assert_int_equal(lsamp_patterns_build(n, 6, NULL, size), LSAMP_ERR_ARGUMENT);
        assert_int_equal(lsamp_patterns_build(0, 6, b, size), LSAMP_ERR_ARGUMENT);
        assert_true(memcmp(a, b, size) != 0);
        for (j = 0; j < 256; j++) {
            const float *at = a + (size_t)j * n * 2u;
            memset(seen, 0, n);
            for (k = 0; k < n; k++) {
                assert_true(at[2 * k] >= 0.0f && at[2 * k] < 1.0f && at[2 * k + 1] >= 0.0f && at[2 * k + 1] < 1.0f);
                assert_true((double)at[2 * k] * n >= k && (double)at[2 * k] * n < k + 1);
            }
            if (n != 16 && n != 64 && n != 256) continue;
            for (k = 0; k < n; k++) {
                uint32_t cell = (uint32_t)(at[2 * k] * (float)root) * root + (uint32_t)(at[2 * k + 1] * (float)root);
                assert_true(!seen[cell]++);
            }
        }
        /* No two patterns have the same second numbers: neighbouring pixels would have the same noise. */
        for (j = 1; n >= 7 && j < 256; j++)
            for (k = 0; k < j; k++) {
                const float *at = a + (size_t)j * n * 2u, *other = a + (size_t)k * n * 2u;
                uint32_t i, same = 0;
                for (i = 0; i < n; i++) same += !(at[2 * i + 1] < other[2 * i + 1] || at[2 * i + 1] > other[2 * i + 1]);
                assert_true(same < n);
            }
        free(a);
        free(b);
        free(seen);
    }
}

static void patterns_have_the_mean_of_a_sequence(void **state)
{
    static float patterns[256 * 64 * 2];
    const float p[3] = { 0, 0, 0 }, up[3] = { 0, 0, 1 };
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_RECTANGLE, 1.0);
    lsamp_material m = lambert(1.0);
    light_box box;
    estimate a, b;
    (void)state;

    check_ok(lsamp_patterns_build(64, 1, patterns, sizeof patterns));
    set3(d.position, -0.5, -0.5, 1);
    set3(d.u, 0, 1, 0);
    set3(d.v, 1, 0, 0);
    box = make_light(&d);
    a = estimate_at(box.light, &m, p, up, NULL, LSAMP_SAMPLING_LIGHT, 64, 2000, NULL);
    b = estimate_at(box.light, &m, p, up, NULL, LSAMP_SAMPLING_LIGHT, 64, 2000, patterns);
    print_message("  sd of 64: sequence %.2e, patterns %.2e\n", a.sd, b.sd);
    check_near("patterns", b.mean[1], 0.23945647, 4.0 * b.sd / 16.0);    /* 256 different ones */
    check_near("sequence", a.mean[1], 0.23945647, 4.0 * a.standard_error);
    free(box.memory);
}

/* 300 frames of 16 samples: the mean converges like a sequence, with patterns too, past their 256. */
static void the_mean_of_frames_converges_like_a_sequence(void **state)
{
    static float patterns[256 * 16 * 2];
    static float w[4 * 16 * 3], distance[4 * 16], weights[4 * 16 * 3];
    const float p[3] = { 0, 0, 0 }, up[3] = { 0, 0, 1 };
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_RECTANGLE, 1.0);
    lsamp_material m = lambert(1.0);
    light_box box;
    int with;
    (void)state;

    check_ok(lsamp_patterns_build(16, 1, patterns, sizeof patterns));
    set3(d.position, -0.5, -0.5, 1);
    set3(d.u, 0, 1, 0);
    set3(d.v, 1, 0, 0);
    box = make_light(&d);
    for (with = 0; with < 2; with++) {
        double sums[3], plain = 0.0, squares = 0.0, sd;
        float radiance[3], mean[3];
        lsamp_progressive total;
        lsamp_sample_desc desc;
        lsamp_points points;
        lsamp_samples out;
        uint32_t frame;

        total.sums = sums;
        total.count = 3;
        memset(&desc, 0, sizeof desc);
        memset(&points, 0, sizeof points);
        desc.sample_count = 16;
        desc.patterns = with ? patterns : NULL;
        points.count = 1;
        points.positions = p;
        points.normals = up;
        points.position_stride = points.normal_stride = 12;
        points.materials = &m;
        out.directions = w;
        out.distances = distance;
        out.weights = weights;
        out.coords = NULL;
        check_ok(lsamp_progressive_reset(&total));
        assert_int_equal(lsamp_progressive_mean(&total, mean), LSAMP_ERR_ORDER);
        for (frame = 0; frame < 600; frame++) {
            desc.frame = frame;
            check_ok(lsamp_sample(&desc, box.light, &points, &out, NULL));
            set3(radiance, 0, 0, 0);
            check_ok(lsamp_accumulate(1, 16, weights, NULL, radiance, 12));
            check_ok(lsamp_progressive_add(&total, radiance));
            plain += (double)radiance[1];
            squares += (double)radiance[1] * (double)radiance[1];
        }
        check_ok(lsamp_progressive_mean(&total, mean));
        check_near("mean of frames", (double)mean[1], plain / 600.0, 1e-7);
        /* four standard errors: 600 frames, of which patterns make 256 different ones; a sequence does better */
        sd = sqrt(squares / 600.0 - plain / 600.0 * (plain / 600.0));
        print_message("  600 frames of 16, %s: error %.2e, sd of a frame %.2e\n", with ? "patterns" : "sequence",
                      (double)mean[1] - 0.23945647, sd);
        check_near("converged", (double)mean[1], 0.23945647, 4.0 * sd / sqrt(with ? 256.0 : 600.0));
        check_ok(lsamp_progressive_reset(&total));
        assert_true(total.frame_count == 0 && sums[0] == 0.0);
    }
    free(box.memory);
    {   /* a float sum stops: 1e6 frames of 1e-3 */
        double sums[1];
        lsamp_progressive total;
        float value = 1e-3f, mean;
        int i;
        total.sums = sums;
        total.count = 1;
        check_ok(lsamp_progressive_reset(&total));
        for (i = 0; i < 1000000; i++) check_ok(lsamp_progressive_add(&total, &value));
        check_ok(lsamp_progressive_mean(&total, &mean));
        CONFORM("T16", "mean of 1e6 frames of 1e-3, times 1000", 1, 1000.0 * (double)mean, 1e-6);
    }
}

/* The same samples however a batch is cut, and whatever lies beside a point. */
static void a_batch_may_be_cut_anywhere(void **state)
{
    enum { N = 37, S = 5 };
    static float p[N * 3], n[N * 3], wo[N * 3];
    static lsamp_material m[N];
    static uint32_t pixels[N];
    static float whole[4][N * S * 3], parts[4][N * S * 3];
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_SPHERE, 1.0);
    lsamp_sample_desc desc;
    lsamp_points points;
    lsamp_samples out;
    size_t i, useful, sum = 0, step;
    light_box box;
    (void)state;

    set3(d.position, 0, 0, 2);
    d.radius = 0.5f;
    box = make_light(&d);
    for (i = 0; i < N; i++) {
        set3(p + 3 * i, rnd(), rnd(), 0);
        polar(n + 3 * i, rnd(), 6.0 * rnd());
        polar(wo + 3 * i, rnd(), 6.0 * rnd());
        m[i] = test_material((int)i % MATERIALS);
        pixels[i] = (uint32_t)(1000.0 * rnd());
    }
    memset(&desc, 0, sizeof desc);
    memset(&points, 0, sizeof points);
    desc.sample_count = S;
    points.position_stride = points.normal_stride = points.to_eye_stride = 12;
    points.material_stride = sizeof(lsamp_material);
    for (step = N; step >= 1; step = step == N ? 5 : 0) {
        float(*to)[N * S * 3] = step == N ? whole : parts;
        for (i = 0; i < N; i += step) {
            points.count = i + step < N ? step : N - i;
            points.positions = p + 3 * i;
            points.normals = n + 3 * i;
            points.to_eye = wo + 3 * i;
            points.materials = m + i;
            points.pixels = pixels + i;
            out.directions = to[0] + 3 * S * i;
            out.distances = to[1] + S * i;
            out.coords = to[2] + 3 * S * i;
            out.weights = to[3] + 3 * S * i;
            check_ok(lsamp_sample(&desc, box.light, &points, &out, &useful));
            sum += useful;
        }
    }
    assert_memory_equal(whole, parts, sizeof whole);
    useful = 0;
    for (i = 0; i < N * S; i++) useful += whole[3][3 * i] + whole[3][3 * i + 1] + whole[3][3 * i + 2] > 0.0f;
    assert_true(sum == 2 * useful && useful > 0);
    free(box.memory);
}

static void bad_input_is_refused(void **state)
{
    static const float shorter[3] = { 0, 0.9f, 0 };
    const float nan3[3] = { NAN, 0, 0 }, zero[3] = { 0, 0, 0 }, up[3] = { 0, 0, 1 };
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_SPHERE, 1.0), bad;
    lsamp_material m = lambert(0.5), broken;
    lsamp_sample_desc desc, wrong;
    lsamp_points points, q;
    lsamp_samples out, none;
    float w[3] = { 9, 9, 9 }, distance = 9, weights[3] = { 9, 9, 9 }, coords[3] = { 9, 9, 9 }, f[3], pdf;
    lsamp_light *light = NULL;
    lsamp_emission e;
    light_box box;
    size_t useful = 77;
    (void)state;

    set3(d.position, 0, 0, 2);
    d.radius = 0.5f;
    bad = d, bad.radius = 0.0f;
    assert_true(lsamp_light_bytes(&bad) == 0 && lsamp_light_bytes(NULL) == 0);
    bad = d, bad.radius = NAN;
    assert_true(lsamp_light_bytes(&bad) == 0);
    bad = d, bad.position[1] = INFINITY;
    assert_true(lsamp_light_bytes(&bad) == 0);
    bad = d, bad.radiance[1] = -1.0f;
    assert_true(lsamp_light_bytes(&bad) == 0);
    bad = d, bad.kind = (lsamp_light_kind)99;
    assert_true(lsamp_light_bytes(&bad) == 0);
    bad = d, bad.texels = up;
    assert_true(lsamp_light_bytes(&bad) == 0);
    bad = d, bad.width = 4;
    assert_true(lsamp_light_bytes(&bad) == 0);
    bad = d, bad.kind = LSAMP_LIGHT_RECTANGLE;        /* no edges */
    assert_true(lsamp_light_bytes(&bad) == 0);
    bad = d, bad.kind = LSAMP_LIGHT_SUN;              /* direction 0 */
    assert_true(lsamp_light_bytes(&bad) == 0);
    bad = d, bad.kind = LSAMP_LIGHT_CALLBACK;
    assert_true(lsamp_light_bytes(&bad) == 0);
    bad = d, bad.time = NAN;
    assert_true(lsamp_light_bytes(&bad) == 0);

    box = make_light(&d);
    assert_int_equal(lsamp_light_init(NULL, box.memory, 4096, &light, NULL), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_light_init(&d, NULL, 4096, &light, NULL), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_light_init(&d, box.memory, 8, &light, NULL), LSAMP_ERR_MEMORY);
    assert_int_equal(lsamp_light_init(&bad, box.memory, 4096, &light, NULL), LSAMP_ERR_DESC);
    assert_null(light);
    {
        double room[2048];                                 /* 8-byte aligned is enough, and one frame is none more */
        lsamp_light_desc small_sky = d;
        int k;
        small_sky.texels = NULL;
        small_sky.width = small_sky.height = 0;
        small_sky.frame_count = 1;
        for (k = 0; k < 2; k++)
            assert_int_equal(lsamp_light_init(&small_sky, room + k, sizeof room - 8, &light, NULL), LSAMP_OK);
        assert_int_equal(lsamp_light_init(&small_sky, (char *)room + 4, sizeof room - 8, &light, NULL),
                         LSAMP_ERR_MEMORY);
        light = NULL;
    }
    assert_int_equal(lsamp_light_sample(box.light, nan3, zero, &e), 0);
    assert_int_equal(lsamp_light_hit(box.light, zero, nan3, &e), 0);
    assert_int_equal(lsamp_light_hit(box.light, zero, zero, &e), 0);

    memset(&desc, 0, sizeof desc);
    memset(&points, 0, sizeof points);
    desc.sample_count = 1;
    points.count = 1;
    points.positions = zero;
    points.normals = up;
    points.position_stride = points.normal_stride = 12;
    points.materials = &m;
    out.directions = w;
    out.distances = &distance;
    out.coords = coords;
    out.weights = weights;
#define REFUSED(code, call) \
    do { \
        lsamp_result got_ = call; \
        assert_int_equal(got_, code); \
        assert_true(w[0] == 9 && distance == 9 && weights[0] == 9 && coords[2] == 9 && useful == 77); \
    } while (0)
    REFUSED(LSAMP_ERR_ARGUMENT, lsamp_sample(NULL, box.light, &points, &out, &useful));
    REFUSED(LSAMP_ERR_ARGUMENT, lsamp_sample(&desc, NULL, &points, &out, &useful));
    REFUSED(LSAMP_ERR_ARGUMENT, lsamp_sample(&desc, box.light, NULL, &out, &useful));
    REFUSED(LSAMP_ERR_ARGUMENT, lsamp_sample(&desc, box.light, &points, NULL, &useful));
    none = out, none.weights = NULL;
    REFUSED(LSAMP_ERR_ARGUMENT, lsamp_sample(&desc, box.light, &points, &none, &useful));
    wrong = desc, wrong.sample_count = 0;
    REFUSED(LSAMP_ERR_DESC, lsamp_sample(&wrong, box.light, &points, &out, &useful));
    wrong = desc, wrong.sample_count = 65537;
    REFUSED(LSAMP_ERR_DESC, lsamp_sample(&wrong, box.light, &points, &out, &useful));
    wrong = desc, wrong.sampling = (lsamp_sampling)17;
    REFUSED(LSAMP_ERR_DESC, lsamp_sample(&wrong, box.light, &points, &out, &useful));
    q = points, q.normals = shorter;
    REFUSED(LSAMP_ERR_INPUT, lsamp_sample(&desc, box.light, &q, &out, &useful));
    q = points, q.position_stride = 13;
    REFUSED(LSAMP_ERR_ARGUMENT, lsamp_sample(&desc, box.light, &q, &out, &useful));
    q = points, q.to_eye = shorter, q.to_eye_stride = 12;
    REFUSED(LSAMP_ERR_INPUT, lsamp_sample(&desc, box.light, &q, &out, &useful));
    q = points, q.count = SIZE_MAX / 8;
    REFUSED(LSAMP_ERR_LIMIT, lsamp_sample(&desc, box.light, &q, &out, &useful));
    broken = m, broken.diffuse[1] = 1.5f;
    q = points, q.materials = &broken;
    REFUSED(LSAMP_ERR_INPUT, lsamp_sample(&desc, box.light, &q, &out, &useful));
    broken = m, broken.kind = LSAMP_MATERIAL_LAFORTUNE, broken.lobe_count = 1;
    REFUSED(LSAMP_ERR_INPUT, lsamp_sample(&desc, box.light, &q, &out, &useful));
    q = points, q.count = 0;
    check_ok(lsamp_sample(&desc, box.light, &q, &out, NULL));
    assert_int_equal(lsamp_accumulate(1, 1, NULL, NULL, w, 12), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_accumulate(1, 1, weights, NULL, w, 11), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_accumulate(1, 0, weights, NULL, w, 12), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_brdf_eval(NULL, up, NULL, up, up, f, &pdf), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_brdf_eval(&m, up, NULL, up, zero, f, &pdf), LSAMP_ERR_INPUT);
    assert_int_equal(lsamp_brdf_sample(&m, up, NULL, up, nan3, w, f, &pdf), LSAMP_ERR_INPUT);
    assert_int_equal(lsamp_brdf_eval(&broken, up, NULL, up, up, f, &pdf), LSAMP_ERR_INPUT);
    assert_int_equal(lsamp_progressive_add(NULL, w), LSAMP_ERR_ARGUMENT);
    free(box.memory);
}

static void keep_message(void *user, const char *message)
{
    char *last = (char *)user;
    assert_int_equal(last[0], 0);                               /* at most once a call */
    snprintf(last, 256, "%s", message);
}

static void messages_name_what_was_refused(void **state)
{
    static const float corners[9] = { 0, 0, 0, 1, 0, 0, 0, 0, 1 }, at[6] = { 0, 0, 0, 0, 0, 0 };
    static const float normals[6] = { 0, 1, 0, 0, 0.5f, 0 };
    static const uint16_t triangle[3] = { 0, 7, 1 };
    lsamp_mesh mesh = { corners, 3, 0, NULL, 3, triangle };
    char last[256] = "";
    double memory[512];
    float w[6], distance[2], weights[6];
    lsamp_samples out = { w, distance, NULL, weights };
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_MESH, 1.0);
    lsamp_material m = lambert(0.5);
    lsamp_sample_desc desc;
    lsamp_points points;
    lsamp_light *light;
    (void)state;
    d.system.log = keep_message;
    d.system.user = last;
    d.mesh = &mesh;
    assert_int_equal(lsamp_light_init(&d, memory, sizeof memory, &light, NULL), LSAMP_ERR_INPUT);
    assert_string_equal(last, "lsamp_light_init: desc.mesh: index 1 of triangle 0 is 7, but the mesh has 3 vertices");
    d.kind = LSAMP_LIGHT_SPOT;
    d.direction[1] = 1;
    d.cone_half_angle = 2;
    last[0] = 0;
    assert_int_equal(lsamp_light_init(&d, memory, sizeof memory, &light, NULL), LSAMP_ERR_DESC);
    assert_string_equal(last, "lsamp_light_init: desc.cone_half_angle is 2; it must be 5e-7..pi / 2");
    d.cone_half_angle = 1;
    last[0] = 0;
    check_ok(lsamp_light_init(&d, memory, sizeof memory, &light, NULL));
    assert_string_equal(last, "");
    memset(&desc, 0, sizeof desc);
    memset(&points, 0, sizeof points);
    desc.system = d.system;
    points.count = 2;
    points.positions = at;
    points.normals = normals;
    points.materials = &m;
    assert_int_equal(lsamp_sample(&desc, light, &points, &out, NULL), LSAMP_ERR_DESC);
    assert_string_equal(last, "lsamp_sample: desc.sample_count is 0; it must be 1..65536");
    desc.sample_count = 1;
    last[0] = 0;
    assert_int_equal(lsamp_sample(&desc, light, &points, &out, NULL), LSAMP_ERR_INPUT);
    assert_string_equal(last, "lsamp_sample: points.normals[1] has the length 0.5; it must be 1 (0.97..1.03), or 0");
}

static void a_normal_of_zeros_is_no_receiver(void **state)
{
    static const float at[6] = { 0, 0, 0, 0, 0, 0 }, normals[6] = { 0, 1, 0, 0, 0, 0 };
    float w[6], distance[2], coords[6], weights[6];
    lsamp_samples out = { w, distance, coords, weights };
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_ENVIRONMENT, 1.0);
    light_box box = make_light(&d);
    lsamp_material m = lambert(0.5);
    lsamp_sample_desc desc;
    lsamp_points points;
    size_t useful = 9;
    (void)state;
    memset(&desc, 0, sizeof desc);
    memset(&points, 0, sizeof points);
    desc.sample_count = 1;
    desc.sampling = LSAMP_SAMPLING_BRDF;
    points.count = 2;
    points.positions = at;
    points.normals = normals;
    points.materials = &m;
    check_ok(lsamp_sample(&desc, box.light, &points, &out, &useful));
    assert_int_equal(useful, 1);
    assert_true(weights[0] > 0 && weights[3] == 0 && weights[4] == 0 && weights[5] == 0);
    free(box.memory);
}

static void short_indices_make_the_same_light(void **state)
{
    static const float corners[12] = { -1, 1, -1, 1, 1, -1, 1, 1, 1, -1, 1, 1 };
    static const uint32_t triangles[6] = { 0, 1, 2, 0, 2, 3 };
    static const uint16_t short_triangles[6] = { 0, 1, 2, 0, 2, 3 };
    lsamp_mesh mesh[2] = { { corners, 4, 0, triangles, 6, NULL }, { corners, 4, 0, NULL, 6, short_triangles } };
    light_box box[2];
    float *pieces[2];
    size_t count[2], i;
    (void)state;
    for (i = 0; i < 2; i++) {
        lsamp_light_desc d = light_desc(LSAMP_LIGHT_MESH, 1.0);
        d.mesh = &mesh[i];
        d.place_count = 8;
        box[i] = make_light(&d);
        count[i] = lsamp_light_triangles(box[i].light, NULL);
        pieces[i] = (float *)malloc(count[i] * 36);
        assert_non_null(pieces[i]);
        lsamp_light_triangles(box[i].light, pieces[i]);
    }
    assert_true(count[0] == count[1] && count[0] >= 8);
    assert_memory_equal(pieces[0], pieces[1], count[0] * 36);
    for (i = 0; i < 2; i++) {
        free(pieces[i]);
        free(box[i].memory);
    }
}

/* ---- textures of A and L, linear between what they hold (section 5, figure 12) ---- */

enum { LW = 5, LH = 4 };

/* Some texels are black, beside bright ones. */
static void fill_texels(float *texels)
{
    int i;
    for (i = 0; i < 3 * LW * LH; i++) texels[i] = (i / 3) % 3 ? (float)((i * 7) % 11) : 0.0f;
}

/* L at x, y in doubles: between the four nearest centres; columns go round or end. */
static double linear_at(const float *texels, int c, double x, double y, int round)
{
    double fx = x * LW - 0.5, fy = y * LH - 0.5, sum = 0.0;
    int i = (int)floor(fx), j = (int)floor(fy), k;
    fx -= i;
    fy -= j;
    for (k = 0; k < 4; k++) {
        int column = i + k % 2, row = j + k / 2;
        column = round ? (column + LW) % LW : column < 0 ? 0 : column > LW - 1 ? LW - 1 : column;
        row = row < 0 ? 0 : row > LH - 1 ? LH - 1 : row;
        sum += (k % 2 ? fx : 1.0 - fx) * (k / 2 ? fy : 1.0 - fy) * (double)texels[3 * (row * LW + column) + c];
    }
    return sum;
}

static lsamp_light_desc square_above(float *texels)
{
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_RECTANGLE, 1.0);
    set3(d.position, 0, 0, 1);
    set3(d.u, 0, 1, 0);
    set3(d.v, 1, 0, 0);
    if (!texels) return d;
    fill_texels(texels);
    d.texels = texels;
    d.width = LW;
    d.height = LH;
    d.filter = LSAMP_TEXELS_LINEAR;
    return d;
}

/* A ray that hits a light sees what lies between the centres, on a square that ends and on a ball that goes round. */
static void linear_texels_are_linear_between_their_centres(void **state)
{
    const float p[3] = { 0.4f, 0.6f, 0.0f };
    float texels[3 * LW * LH];
    double off = 0.0;
    int kind, i;
    (void)state;
    for (kind = 0; kind < 2; kind++) {
        lsamp_light_desc d = square_above(texels);
        light_box box;
        int hits = 0;
        if (kind) {
            d.kind = LSAMP_LIGHT_SPHERE;
            set3(d.position, 0.4, 0.6, 2);
            d.radius = 1.5f;
        }
        box = make_light(&d);
        for (i = 0; i < 4000; i++) {
            lsamp_emission e;
            float w[3];
            int c;
            polar(w, rnd() * (kind ? 0.85 : 0.7), rnd() * 2.0 * PI);
            if (!lsamp_light_hit(box.light, p, w, &e)) continue;
            hits++;
            assert_true(e.pdf > 0.0f);
            for (c = 0; c < 3; c++) {
                double want = linear_at(texels, c, (double)e.coords[0], (double)e.coords[1], kind);
                off = fmax(off, fabs((double)e.radiance[c] - want));
            }
        }
        assert_true(hits > 1000);
        free(box.memory);
    }
    CONFORM_MAX("T43", "L between the centres of 5 x 4 texels of up to 10, off the bilinear form", 2e-5, off);
}

/* Any density has the mean of the bilinear L, though some texels are black: what is sampled by the mean over a texel
   misses nothing that shines into it. */
static void t43_linear_texels_light_as_their_integral(void **state)
{
    const float up[3] = { 0, 0, 1 }, centre[3] = { 0.5f, 0.5f, 0.0f }, p[3] = { 0, 0, 0 };
    float texels[3 * LW * LH];
    lsamp_light_desc d = square_above(texels), sky = light_desc(LSAMP_LIGHT_ENVIRONMENT, 1.0);
    light_box box;
    double want = 0.0, seen = 0.0, sum = 0.0;
    int i, j;
    (void)state;

    for (i = 0; i < 600; i++)           /* v runs along x, u along y */
        for (j = 0; j < 600; j++) {
            double s = (i + 0.5) / 600.0, t = (j + 0.5) / 600.0, x = t - 0.5, y = s - 0.5, d2 = x * x + y * y + 1.0;
            want += linear_at(texels, 1, s, t, 0) / (d2 * d2) / 360000.0;
            sum += linear_at(texels, 1, s, t, 0) / 360000.0;
        }
    check_irradiance("T43", "irradiance, unit square of 5 x 4 texels, linear between them", &d, centre, up, want, 1);
    for (i = 0; i < LW * LH; i++) seen += (double)texels[3 * i + 1] / (LW * LH);
    CONFORM("T43", "mean of L over the square, of that of its texels", 1, sum / seen, 1e-4);

    sky.texels = texels;
    sky.width = LW;
    sky.height = LH;
    sky.rotation = 0.7f;
    sky.filter = LSAMP_TEXELS_LINEAR;
    want = 0.0;
    for (i = 0; i < 1200; i++)          /* azimuth; the angle from +Y */
        for (j = 0; j < 600; j++) {
            double x = (i + 0.5) / 1200.0, y = (j + 0.5) / 600.0, theta = PI * y;
            double z = sin(theta) * sin(2.0 * PI * (x - 0.5) - (double)sky.rotation);
            if (z <= 0.0) continue;
            want += linear_at(texels, 1, x, y, 1) * z * sin(theta) * (2.0 * PI / 1200.0) * (PI / 600.0);
        }
    check_irradiance("T43", "irradiance, sky of 5 x 4 texels, linear between them", &sky, p, up, want, 1);

    box = make_light(&d);               /* drawn and hit are one density */
    for (i = 0; i < 500; i++) {
        float u[3];
        lsamp_emission drawn, hit;
        set3(u, rnd(), rnd(), 0);
        if (!lsamp_light_sample(box.light, centre, u, &drawn)) continue;
        if (!lsamp_light_hit(box.light, centre, drawn.direction, &hit)) continue;
        if (fabsf(hit.coords[0] * LW - roundf(hit.coords[0] * LW)) < 1e-3f) continue;       /* at edges of texels */
        if (fabsf(hit.coords[1] * LH - roundf(hit.coords[1] * LH)) < 1e-3f) continue;
        check_near("density", (double)drawn.pdf, (double)hit.pdf, 1e-4 * (double)hit.pdf);
    }
    free(box.memory);
}

/* Figure 12: what a mirror shows of the light along a line. By nearest texels it jumps by the whole contrast; linearly
   it rises by no more than the contrast within a texel's width. */
static void t43_a_highlight_of_linear_texels_is_continuous(void **state)
{
    enum { STEPS = 2000 };
    const float p[3] = { 0.5f, 0.5f, 0.0f };
    float texels[3 * LW * LH];
    double step[2] = { 0.0, 0.0 };
    int way, i;
    (void)state;
    for (way = 0; way < 2; way++) {
        lsamp_light_desc d = square_above(texels);
        light_box box;
        double last = -1.0;
        for (i = 0; i < 3 * LW * LH; i++) texels[i] = (float)(i / 3 % 2);
        d.height = 1;
        d.filter = way ? LSAMP_TEXELS_LINEAR : LSAMP_TEXELS_NEAREST;
        box = make_light(&d);
        for (i = 0; i < STEPS; i++) {
            double y = (i + 0.5) / STEPS - 0.5, length = sqrt(y * y + 1.0);
            lsamp_emission e;
            float w[3];
            set3(w, 0, y / length, 1.0 / length);
            memset(&e, 0, sizeof e);
            (void)lsamp_light_hit(box.light, p, w, &e);     /* black texels are not seen */
            if (last >= 0.0) step[way] = fmax(step[way], fabs((double)e.radiance[1] - last));
            last = (double)e.radiance[1];
        }
        free(box.memory);
    }
    CONFORM("T43", "largest step of a highlight of stripes 0 and 1, nearest texels", 1, step[0], 1e-6);
    CONFORM("T43", "the same, linear texels, times steps a texel", 1, step[1] * STEPS / LW, 2e-3);
}

/* A grid of 2 x 2 points is a parallelogram; one of 64 x 33 that closes is nearly a ball. Moved corners bend it. */
static void t43_t73_a_surface_lights_as_the_shape_that_it_is(void **state)
{
    enum { U = 64, V = 33 };
    static const float square[12] = { 0, 0, 1,  0, 1, 1,  1, 0, 1,  1, 1, 1 };
    static float ball_points[U * V * 3];
    const float up[3] = { 0, 0, 1 }, centre[3] = { 0.5f, 0.5f, 0.0f }, p[3] = { 0, 0, 0 }, u[3] = { 0.3f, 0.6f, 0.9f };
    float texels[3 * LW * LH], places[6 * 4];
    lsamp_emission seen;
    lsamp_light_desc d = light_desc(LSAMP_LIGHT_SURFACE, 1.0), flat;
    lsamp_surface s = { 2, 2, square, 0 }, round = { U, V, ball_points, 1 };
    light_box box;
    estimate e[2];
    int i, j;
    (void)state;

    d.surface = &s;
    check_irradiance("T43", "irradiance, unit square above the point, as a surface", &d, centre, up, PI * 0.23945647,
                     0);
    box = make_light(&d);               /* it has two coordinates, where callbacks and meshes have three */
    assert_int_equal(lsamp_light_sample(box.light, centre, u, &seen), 1);
    check_near("the third coordinate of a surface", (double)seen.coords[2], 0.0, 0.0);
    free(box.memory);
    flat = square_above(texels);
    d.texels = texels;
    d.width = LW;
    d.height = LH;
    d.filter = LSAMP_TEXELS_LINEAR;
    for (i = 0; i < 2; i++) {           /* with the same texels and numbers it is the rectangle */
        box = make_light(i ? &flat : &d);
        e[i] = irradiance(box.light, centre, up, LSAMP_SAMPLING_LIGHT);
        free(box.memory);
    }
    check_near("textured square as a surface", e[0].mean[1], e[1].mean[1], 1e-4 * e[1].mean[1]);

    for (j = 0; j < V; j++)             /* from -Z to +Z, so that (along rows) x (across) points outwards */
        for (i = 0; i < U; i++) {
            float *q = ball_points + 3 * (j * U + i);
            polar(q, PI - PI * j / (V - 1), 2.0 * PI * i / U);
            for (int c = 0; c < 3; c++) q[c] *= 0.5f;
            q[2] += 2.0f;
        }
    d = light_desc(LSAMP_LIGHT_SURFACE, 1.0);
    d.surface = &round;
    box = make_light(&d);
    e[0] = irradiance(box.light, p, up, LSAMP_SAMPLING_LIGHT);
    free(box.memory);
    /* pi r^2 / d^2 of a ball; flat pieces lose less than 1 - cos(pi / 64) of the radius, and as much along it */
    CONFORM("T73", "irradiance, ball as a surface of 64 x 33 points, of the ball's", 1, e[0].mean[1] / (PI / 16.0),
            4.0 * e[0].standard_error / (PI / 16.0) + 5e-3);

    assert_int_equal(lsamp_surface_locations(&s, 3, 2, 0.25f, places), LSAMP_OK);
    for (i = 0; i < 6; i++) {           /* rows run along y; the square looks down */
        check_near("place x", (double)places[4 * i], i / 3 ? 0.75 : 0.25, 1e-6);
        check_near("place y", (double)places[4 * i + 1], (i % 3 + 0.5) / 3.0, 1e-6);
        check_near("place z", (double)places[4 * i + 2], 0.75, 1e-6);
        check_near("place w", (double)places[4 * i + 3], 1.0, 0.0);
    }
    assert_int_equal(lsamp_surface_locations(NULL, 3, 2, 0, places), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_surface_locations(&s, 0, 2, 0, places), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_surface_locations(&s, 3, 2, (float)NAN, places), LSAMP_ERR_INPUT);
    s.width = 1;
    assert_int_equal(lsamp_surface_locations(&s, 3, 2, 0, places), LSAMP_ERR_INPUT);
    d.surface = &s;
    assert_int_equal(lsamp_light_bytes(&d), 0);
    d.surface = NULL;
    assert_int_equal(lsamp_light_bytes(&d), 0);
    flat.filter = LSAMP_TEXELS_COUNT;
    assert_int_equal(lsamp_light_bytes(&flat), 0);
}

static void results_have_texts(void **state)
{
    int i;
    (void)state;
    assert_string_equal(lsamp_result_text(LSAMP_OK), "ok");
    for (i = 0; i < LSAMP_RESULT_COUNT; i++)
        assert_string_not_equal(lsamp_result_text((lsamp_result)i), "unknown result");
    assert_string_equal(lsamp_result_text(LSAMP_RESULT_COUNT), "unknown result");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_of_a_brdf_sum_to_its_albedo),
        cmocka_unit_test(brdfs_equal_their_closed_forms),
        cmocka_unit_test(t10_a_uniform_sky_lights_every_normal_by_pi),
        cmocka_unit_test(t11_t12_rows_of_a_sky_count_by_solid_angle),
        cmocka_unit_test(a_ray_hits_the_texel_that_is_sampled_there),
        cmocka_unit_test(t15_texels_are_chosen_by_their_light),
        cmocka_unit_test(t16_one_bright_texel_of_a_large_map_keeps_its_share),
        cmocka_unit_test(t18_t20_t21_one_texel_lights_at_any_rotation),
        cmocka_unit_test(t22_bad_texels_are_counted_and_black),
        cmocka_unit_test(t23_a_wall_hides_half_of_the_sky_and_a_roof_all),
        cmocka_unit_test(t43_a_rectangle_lights_as_in_closed_form),
        cmocka_unit_test(a_disc_lights_as_in_closed_form),
        cmocka_unit_test(t73_a_sphere_lights_as_in_closed_form),
        cmocka_unit_test(a_thin_line_lights_as_in_closed_form),
        cmocka_unit_test(a_thick_line_lights_as_its_cross_section),
        cmocka_unit_test(suns_points_and_spots_light_as_in_closed_form),
        cmocka_unit_test(parts_of_a_texture_light_as_the_whole),
        cmocka_unit_test(coordinates_in_a_domain_give_the_sample_back),
        cmocka_unit_test(radiance_is_linear_between_frames),
        cmocka_unit_test(shapes_and_emission_by_callback_light_as_in_closed_form),
        cmocka_unit_test(a_mesh_lights_as_the_rectangle_that_it_is),
        cmocka_unit_test(every_strategy_has_the_same_mean),
        cmocka_unit_test(both_strategies_together_vary_less_than_either),
        cmocka_unit_test(patterns_lie_in_the_square_and_differ_by_seed),
        cmocka_unit_test(patterns_have_the_mean_of_a_sequence),
        cmocka_unit_test(the_mean_of_frames_converges_like_a_sequence),
        cmocka_unit_test(a_batch_may_be_cut_anywhere),
        cmocka_unit_test(bad_input_is_refused),
        cmocka_unit_test(linear_texels_are_linear_between_their_centres),
        cmocka_unit_test(t43_linear_texels_light_as_their_integral),
        cmocka_unit_test(t43_a_highlight_of_linear_texels_is_continuous),
        cmocka_unit_test(t43_t73_a_surface_lights_as_the_shape_that_it_is),
        cmocka_unit_test(results_have_texts),
        cmocka_unit_test(messages_name_what_was_refused),
        cmocka_unit_test(a_normal_of_zeros_is_no_receiver),
        cmocka_unit_test(short_indices_make_the_same_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
