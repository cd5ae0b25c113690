/* gloss_test - BRDFs in scenes of shadowfield.h: glTF's metal-rough BRDF beside closed forms, beside numerical
   integration of the same light, its reciprocity, beside a path tracer; the same and Phong's lobe in wavelets; what is
   refused. */
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include "conformance.h"

static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };
static const float white[3] = { 1, 1, 1 };

static sfield_scene *scene_of(uint32_t bands)
{
    sfield_scene_desc d;
    sfield_scene *s = NULL;
    memset(&d, 0, sizeof d);
    d.bands = bands;
    assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
    assert_int_equal(sfield_scene_entities(s, NULL, 0), SFIELD_OK);
    return s;
}

/* A sky of random texels. */
static void random_sky(sfield_scene *s, uint64_t seed)
{
    float map[3 * 16 * 8];
    for (int i = 0; i < 3 * 16 * 8; i++) map[i] = rnd_in(&seed, 0, 2);
    assert_int_equal(sfield_scene_environment(s, map, 16, 8, NULL), SFIELD_OK);
}

/* A point, and who looks at it: of a material, or where the exponent is not 0 of a lobe. */
typedef struct eye { float p[3], n[3], v[3], material[5], exponent; } eye;

static void shade_eyes(sfield_scene *s, const eye *e, size_t count, float *rgb, float *gloss)
{
    sfield_points set;
    memset(&set, 0, sizeof set);
    set.count = count;
    set.positions = e->p;
    set.normals = e->n;
    set.to_eye = e->v;
    if (e->exponent > 0) set.exponents = &e->exponent;
    else set.materials = e->material;
    set.exponent_stride = sizeof *e;
    set.position_stride = set.normal_stride = set.to_eye_stride = set.material_stride = sizeof *e;
    set.rgb = rgb;
    set.gloss = gloss;
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
}

/* An eye in the plane of x and y, at a cosine to the normal +y. */
static eye eye_at(double cosine, float base, float metallic, float roughness)
{
    eye e = { { 0, 0, 0 }, { 0, 1, 0 }, { 0, 0, 0 }, { 0, 0, 0, 0, 0 }, 0 };
    e.v[0] = (float)sqrt(1 - cosine * cosine);
    e.v[1] = (float)cosine;
    for (int k = 0; k < 3; k++) e.material[k] = base;
    e.material[3] = metallic;
    e.material[4] = roughness;
    return e;
}

static double dot3(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Three axes, of which the last is n. */
static void axes_of(const double *n, double axes[3][3])
{
    const int least = fabs(n[0]) < 0.6 ? 0 : 1;
    double length;
    for (int k = 0; k < 3; k++) axes[0][k] = (k == least) - n[k] * n[least];
    length = sqrt(dot3(axes[0], axes[0]));
    for (int k = 0; k < 3; k++) {
        axes[0][k] /= length;
        axes[2][k] = n[k];
    }
    for (int k = 0; k < 3; k++)
        axes[1][k] = n[(k + 1) % 3] * axes[0][(k + 2) % 3] - n[(k + 2) % 3] * axes[0][(k + 1) % 3];
}

/* The BRDF as appendix B of glTF 2.0 writes it, in one channel: what is diffuse (of base 1, no metal) and what is
   specular, for unit directions l and v in the frame of the normal z. Written apart from the library's: V is Smith's
   with correlated heights. */
static void brdf_of(const double *l, const double *v, double f0, double alpha, double *diffuse, double *specular)
{
    double h[3], length, d, f, a2 = alpha * alpha, nh;
    for (int k = 0; k < 3; k++) h[k] = l[k] + v[k];
    length = sqrt(dot3(h, h));
    for (int k = 0; k < 3; k++) h[k] /= length;
    nh = h[2];
    f = f0 + (1 - f0) * pow(1 - fabs(dot3(v, h)), 5);
    d = a2 / (PI * pow(nh * nh * (a2 - 1) + 1, 2));
    *diffuse = (1 - f) / PI;
    *specular = f * d * 0.5 / (l[2] * sqrt(a2 + (1 - a2) * v[2] * v[2]) + v[2] * sqrt(a2 + (1 - a2) * l[2] * l[2]));
}

/* Unit spheres about these centres hide some directions: as they are, or as so many bands see each. */
typedef struct spheres { int count; double center[3][3]; uint32_t bands; } spheres;

/* What the bands see of a cap round cosine 1, from cosine x on, at cosine c: half the sum of
   (P(l - 1, x) - P(l + 1, x)) P(l, c). */
static double cap_of(uint32_t bands, double x, double c)
{
    double at_x[3] = { 1, 1, x }, at_c[3] = { 0, 1, c }, sum = 0;      /* of l - 1, l, l + 1 */
    for (uint32_t l = 0; l < bands; l++) {
        sum += 0.5 * (at_x[0] - at_x[2]) * at_c[1];
        for (int k = 0; k < 2; k++) {
            double *p = k ? at_c : at_x;
            p[0] = p[1];
            p[1] = p[2];
            p[2] = ((2 * l + 3) * (k ? c : x) * p[1] - (l + 1) * p[0]) / (l + 2);
        }
    }
    return sum;
}

/* The share of light that comes through from a direction. */
static double open_share(const spheres *s, const float *p, const double *direction)
{
    double open = 1;
    for (int i = 0; s && i < s->count; i++) {
        double c[3], d2, along, rim;
        for (int k = 0; k < 3; k++) c[k] = s->center[i][k] - (double)p[k];
        d2 = dot3(c, c);
        along = dot3(c, direction) / sqrt(d2);
        rim = sqrt(1 - 1 / d2);
        open *= s->bands ? 1 - cap_of(s->bands, rim, along) : along < rim;
    }
    return open;
}

/* The integral over the hemisphere of a light of some bands (NULL: 1) times BRDF and cosine, of one channel: what is
   diffuse by an even grid, what is specular by half vectors that are drawn with D. */
static void integrate(const eye *e, int channel, uint32_t bands, const float *light, const spheres *others, int steps,
                      double *diffuse, double *specular)
{
    const double n[3] = { (double)e->n[0], (double)e->n[1], (double)e->n[2] };
    const double rough = (double)e->material[4], alpha = fmax(rough * rough, 0.002);
    const double f0 = 0.04 + (double)e->material[3] * ((double)e->material[channel] - 0.04);
    const double to_eye[3] = { (double)e->v[0], (double)e->v[1], (double)e->v[2] };
    double axes[3][3], v[3], sum[2] = { 0, 0 };
    axes_of(n, axes);
    for (int k = 0; k < 3; k++) v[k] = dot3(axes[k], to_eye);
    for (int part = 0; part < 2; part++)
        for (int i = 0; i < steps; i++)
            for (int j = 0; j < 2 * steps; j++) {
                const double u = (i + 0.5) / steps, phi = PI * (j + 0.5) / steps;
                double l[3], world[3], weight, value[2], y[64], L = 0;
                if (part == 0) {                    /* a density of cos / pi */
                    l[2] = sqrt(u);
                    l[0] = sqrt(1 - u) * cos(phi);
                    l[1] = sqrt(1 - u) * sin(phi);
                    weight = PI;
                } else if (e->exponent > 0) {       /* of the lobe itself */
                    const double mirror[3] = { -v[0], -v[1], v[2] }, m = (double)e->exponent, c = pow(u, 1 / (m + 1));
                    double about[3][3];
                    axes_of(mirror, about);
                    for (int k = 0; k < 3; k++)
                        l[k] = c * mirror[k] + sqrt(1 - c * c) * (cos(phi) * about[0][k] + sin(phi) * about[1][k]);
                    if (!(l[2] > 0)) continue;
                    weight = (m + 2) / (m + 1) * l[2];
                } else {                            /* of D cos(h) / (4 v . h) */
                    const double c = sqrt((1 - u) / (1 + (alpha * alpha - 1) * u)), s = sqrt(1 - c * c);
                    const double h[3] = { s * cos(phi), s * sin(phi), c }, vh = dot3(v, h);
                    for (int k = 0; k < 3; k++) l[k] = 2 * vh * h[k] - v[k];
                    if (!(l[2] > 0) || !(vh > 0)) continue;
                    weight = 4 * vh * l[2] / c * PI * pow(c * c * (alpha * alpha - 1) + 1, 2) / (alpha * alpha);
                }
                if (e->exponent > 0) {
                    value[0] = 1 / PI;
                    value[1] = 1;
                } else brdf_of(l, v, f0, alpha, &value[0], &value[1]);
                for (int k = 0; k < 3; k++) world[k] = l[0] * axes[0][k] + l[1] * axes[1][k] + l[2] * axes[2][k];
                weight *= open_share(others, e->p, world);
                if (light) sfield_sh_basis(bands, world, y);
                for (uint32_t k = 0; light && k < bands * bands; k++)
                    L += (double)light[(uint32_t)channel * bands * bands + k] * y[k];
                sum[part] += value[part] * weight * (light ? L : 1);
            }
    *diffuse = sum[0] / (2.0 * steps * steps);
    *specular = sum[1] / (2.0 * steps * steps);
}

/* Under a sky of 1: roughness 1 has D = 1 / pi and, without Fresnel, the BRDF 1 / (2 pi (n . l + n . v)), whose albedo
   is 1 - v ln((1 + v) / v). A mirror has F. What is diffuse, along the normal, has a polynomial. */
static void albedos_are_closed_forms(void **state)
{
    const double cosines[4] = { 1, 0.7, 0.4, 0.15 };
    sfield_scene *s = scene_of(0);
    double worst[3] = { 0, 0, 0 };
    float rgb[3], gloss[3];
    eye e;
    (void)state;
    assert_int_equal(sfield_scene_environment(s, white, 1, 1, NULL), SFIELD_OK);
    for (int i = 0; i < 4; i++) {
        const double v = cosines[i], f = pow(1 - v, 5);
        e = eye_at(v, 1, 1, 1);
        shade_eyes(s, &e, 1, rgb, gloss);
        worst[0] = fmax(worst[0], fabs((double)gloss[0] - (1 - v * log((1 + v) / v))));
        e = eye_at(v, 0.5f, 0, 0);
        shade_eyes(s, &e, 1, rgb, gloss);
        worst[1] = fmax(worst[1], fabs((double)gloss[0] - (0.04 + 0.96 * f)));
        assert_true(rgb[0] > 0.9f && rgb[0] < 1);
    }
    e = eye_at(1, 1, 0, 1);
    shade_eyes(s, &e, 1, rgb, gloss);
    /* 0.96 (1 - 8 times the integral of (2 x^3 - x) (1 - x)^5 from sqrt(1/2) to 1) */
    {
        const double a = 1 - sqrt(0.5);     /* in y = 1 - x: (2 (1 - y)^3 - (1 - y)) y^5 */
        const double lost = pow(a, 6) / 6 - 5 * pow(a, 7) / 7 + 6 * pow(a, 8) / 8 - 2 * pow(a, 9) / 9;
        worst[2] = fabs((double)rgb[0] - 0.96 * (1 - 8 * lost));
    }
    CONFORM_MAX("gloss", "albedo of metal of roughness 1 beside 1 - v ln((1 + v) / v)", 2e-3, worst[0]);
    CONFORM_MAX("gloss", "a dielectric mirror beside Schlick's F", 5e-3, worst[1]);
    CONFORM_MAX("gloss", "what is diffuse along the normal", 1e-4, worst[2]);
    sfield_scene_free(s);
}

/* A random eye above a random normal. */
static eye random_eye(uint64_t *seed)
{
    double n[3], v[3], d;
    eye e;
    memset(&e, 0, sizeof e);
    rnd_direction(seed, n);
    do {
        rnd_direction(seed, v);
        d = dot3(n, v);
    } while (!(d > 0.05));
    for (int k = 0; k < 3; k++) {
        e.n[k] = (float)n[k];
        e.v[k] = (float)v[k];
        e.material[k] = rnd_in(seed, 0, 1);
    }
    e.material[3] = rnd(seed) < 0.5 ? 0 : rnd_in(seed, 0, 1);
    e.material[4] = rnd_in(seed, 0, 1);
    return e;
}

/* Relative errors of rgb and gloss, a channel of each eye, beside integrals: roots of mean squares. */
static void compare(sfield_scene *s, const eye *e, size_t count, uint32_t bands, const float *sky,
                    const spheres *others, int steps, double off[2])
{
    float rgb[3 * 96], gloss[3 * 96];
    double sum[2][2] = { { 0, 0 }, { 0, 0 } };
    assert_true(count <= 96);
    shade_eyes(s, e, count, rgb, gloss);
    for (size_t i = 0; i < count; i++) {
        const int c = (int)(i % 3);
        double exact[2];
        integrate(&e[i], c, bands, sky, others, steps, &exact[0], &exact[1]);
        for (int k = 0; k < 2; k++) {
            const double d = (double)(k ? gloss : rgb)[3 * i + (size_t)c] - exact[k];
            sum[k][0] += d * d;
            sum[k][1] += exact[k] * exact[k];
        }
    }
    for (int k = 0; k < 2; k++) off[k] = sqrt(sum[k][0] / sum[k][1]);
}

/* Any normal, view and material under a sky of random texels, as the bands see it, beside numerical integration. */
static void known_lights_are_integrated(void **state)
{
    static const uint32_t bands[3] = { 2, 4, 8 };
    static const char *const names[3] = { "of 2 bands", "of 4 bands", "of 8 bands" };
    uint64_t seed = 5;
    (void)state;
    for (int b = 0; b < 3; b++) {
        sfield_scene *s = scene_of(bands[b]);
        char what[2][80];
        double off[2];
        float sky[3 * 64];
        eye e[48];
        random_sky(s, 7);
        assert_int_equal(sfield_scene_sky(s, sky), SFIELD_OK);
        for (int i = 0; i < 48; i++) e[i] = random_eye(&seed);
        compare(s, e, b == 2 ? 16 : 48, bands[b], sky, NULL, b == 2 ? 64 : 128, off);
        snprintf(what[0], sizeof what[0], "metal-rough, what is diffuse, beside integrals %s", names[b]);
        snprintf(what[1], sizeof what[1], "metal-rough, what is specular, beside integrals %s", names[b]);
        CONFORM_MAX("gloss", what[0], 0.001, off[0]);
        CONFORM_MAX("gloss", what[1], 0.01, off[1]);
        sfield_scene_free(s);
    }
}

/* Two spheres before a sky: a path tracer's rays, whose light the bands limit and whose BRDF they do not, beside the
   products. Where the lobe is narrower than the bands see, so are shadows in it: rays through what they see of
   spheres. */
static void spheres_hide_as_for_a_path_tracer(void **state)
{
    static const float rough[4] = { 1, 0.7f, 0.5f, 0.3f };
    spheres others = { 2, { { 0, 1.2, 0 }, { 2.5, 1.6, 0.8 } }, 0 };
    model m = model_sphere(32, 16, 1);
    sfield_mesh mesh = mesh_of(&m);
    sfield_scene *s = scene_of(4);
    sfield_entity at[2];
    sfield_field *f = NULL;
    sfield_desc d;
    float sky[48];
    uint64_t seed = 3;
    (void)state;
    memset(&d, 0, sizeof d);
    d.shell_count = 12;
    d.position_side = 6;
    assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_OK);
    for (int i = 0; i < 2; i++) {
        at[i] = upright;
        at[i].occlusion = f;
        for (int k = 0; k < 3; k++) at[i].transform[12 + k] = (float)others.center[i][k];
    }
    assert_int_equal(sfield_scene_entities(s, at, 2), SFIELD_OK);
    random_sky(s, 9);
    assert_int_equal(sfield_scene_sky(s, sky), SFIELD_OK);
    for (int r = 0; r < 4; r++) {
        double off[2], limited[2];
        char what[3][100];
        eye e[48];
        for (int i = 0; i < 48; i++) {
            e[i] = eye_at(0.15 + 0.8 * rnd(&seed), 0.8f, i % 2 ? 1.0f : 0.0f, rough[r]);
            e[i].p[0] = rnd_in(&seed, -3, 4);
            e[i].p[2] = rnd_in(&seed, -3, 3);
        }
        others.bands = 0;
        compare(s, e, 48, 4, sky, &others, 64, off);
        others.bands = 4;
        compare(s, e, 48, 4, sky, &others, 64, limited);
        snprintf(what[0], sizeof what[0], "roughness %.1f beside rays, what is diffuse", (double)rough[r]);
        snprintf(what[1], sizeof what[1], "roughness %.1f beside rays, what is specular", (double)rough[r]);
        snprintf(what[2], sizeof what[2], "roughness %.1f beside band-limited rays, what is specular",
                 (double)rough[r]);
        CONFORM_MAX("gloss", what[0], 0.05, off[0]);
        if (r < 2) CONFORM_MAX("gloss", what[1], 0.05, off[1]);
        else CONFORM_NOTE("gloss", what[1], off[1]);
        CONFORM_MAX("gloss", what[2], 0.05, limited[1]);
    }
    sfield_scene_free(s);
    sfield_free(f);
    model_free(&m);
}

/* A scene of wavelets under a smooth sky, which is written as coefficients too; its cubes have 32 texels a side. */
static sfield_scene *wavelets_under(float sky[48])
{
    enum { WIDE = 256, HIGH = 128 };
    static float map[3 * WIDE * HIGH];
    sfield_scene_desc d;
    sfield_scene *s = NULL;
    uint64_t seed = 21;
    for (int i = 0; i < 48; i++) sky[i] = i % 16 ? rnd_in(&seed, -0.5, 0.5) : 6.0f;
    for (int i = 0; i < WIDE * HIGH; i++) {     /* the first row looks to +y, the centre to +x, +z is on its right */
        const double t = PI * (i / WIDE + 0.5) / HIGH, p = 2 * PI * ((i % WIDE + 0.5) / WIDE - 0.5);
        const double w[3] = { sin(t) * cos(p), cos(t), sin(t) * sin(p) };
        for (int k = 0; k < 3; k++) map[3 * i + k] = (float)sh_value(4, sky + 16 * k, w);
    }
    memset(&d, 0, sizeof d);
    d.basis = SFIELD_BASIS_HAAR;
    assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
    assert_int_equal(sfield_scene_entities(s, NULL, 0), SFIELD_OK);
    assert_int_equal(sfield_scene_environment(s, map, WIDE, HIGH, NULL), SFIELD_OK);
    return s;
}

/* On texels, as wide and as narrow lobes as there are: the smallest is a twentieth of a texel. */
static void wavelets_have_both_brdfs(void **state)
{
    static const float rough[5] = { 1, 0.6f, 0.3f, 0.12f, 0 }, exponents[5] = { 1, 10, 50, 200, 1000 };
    float sky[48];
    sfield_scene *s = wavelets_under(sky);
    uint64_t seed = 12;
    double worst[3] = { 0, 0, 0 };
    (void)state;
    for (int r = 0; r < 10; r++) {
        double off[2];
        eye e[16];
        for (int i = 0; i < 16; i++) {
            e[i] = random_eye(&seed);
            e[i].material[4] = rough[r % 5];
            if (r >= 5) e[i].exponent = exponents[r % 5];
        }
        compare(s, e, 16, 4, sky, NULL, 100, off);
        worst[0] = fmax(worst[0], off[0]);
        worst[r < 5 ? 1 : 2] = fmax(worst[r < 5 ? 1 : 2], off[1]);
    }
    CONFORM_MAX("gloss", "wavelets, what is diffuse, beside integrals", 0.01, worst[0]);
    CONFORM_MAX("gloss", "wavelets, metal-rough, what is specular, beside integrals", 0.02, worst[1]);
    CONFORM_MAX("gloss", "wavelets, Phong's lobe beside integrals", 0.02, worst[2]);
    sfield_scene_free(s);
}

/* Normals that are interpolated turn from eyes that still see the surface: these look along it. Both bases send less
   than they get, and the same. */
static void eyes_below_the_horizon_look_along_it(void **state)
{
    static const double cosines[6] = { 0.1, 0.02, 0, -0.05, -0.5, -1 };
    static const float rough[3] = { 0, 0.3f, 1 };
    float sky[48], rgb[2][18], gloss[2][18];
    sfield_scene *s[2];
    (void)state;
    s[0] = scene_of(0);
    s[1] = wavelets_under(sky);
    for (int r = 0; r < 3; r++) {
        eye e[6];
        for (int i = 0; i < 6; i++) e[i] = eye_at(cosines[i], 1, 1, rough[r]);
        for (int b = 0; b < 2; b++) {
            assert_int_equal(sfield_scene_environment(s[b], white, 1, 1, NULL), SFIELD_OK);
            shade_eyes(s[b], e, 6, rgb[b], gloss[b]);
        }
        for (int i = 0; i < 18; i++) {
            assert_true(gloss[0][i] > 0.1f && gloss[0][i] < 1.01f);
            assert_true(fabsf(gloss[1][i] - gloss[0][i]) < 0.05f);
        }
    }
    sfield_scene_free(s[0]);
    sfield_scene_free(s[1]);
}

/* Two spheres again: the shadows of wavelets have edges, so that narrow lobes are right beside rays as they are. */
static void wavelets_hide_as_for_a_path_tracer(void **state)
{
    static const float rough[3] = { 0.7f, 0.3f, 0.15f };
    const spheres others = { 2, { { 0, 1.2, 0 }, { 2.5, 1.6, 0.8 } }, 0 };
    float sky[48];
    sfield_scene *s = wavelets_under(sky);
    model m = model_sphere(32, 16, 1);
    sfield_mesh mesh = mesh_of(&m);
    sfield_entity at[2];
    sfield_field *f = NULL;
    sfield_desc d;
    uint64_t seed = 3;
    (void)state;
    memset(&d, 0, sizeof d);
    d.basis = SFIELD_BASIS_HAAR;
    d.shell_count = 12;
    d.position_side = 8;
    d.keep = 0.1f;
    assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_OK);
    for (int i = 0; i < 2; i++) {
        at[i] = upright;
        at[i].occlusion = f;
        for (int k = 0; k < 3; k++) at[i].transform[12 + k] = (float)others.center[i][k];
    }
    assert_int_equal(sfield_scene_entities(s, at, 2), SFIELD_OK);
    for (int r = 0; r < 4; r++) {
        double off[2];
        char what[100];
        eye e[32];
        for (int i = 0; i < 32; i++) {
            e[i] = eye_at(0.15 + 0.8 * rnd(&seed), 0.8f, i % 2 ? 1.0f : 0.0f, rough[r % 3]);
            e[i].p[0] = rnd_in(&seed, -3, 4);
            e[i].p[2] = rnd_in(&seed, -3, 3);
            if (r == 3) e[i].exponent = 15;
        }
        compare(s, e, 32, 4, sky, &others, 64, off);
        if (r < 3) snprintf(what, sizeof what, "wavelets, roughness %.2f beside rays", (double)rough[r]);
        else snprintf(what, sizeof what, "wavelets, exponent 15 beside rays");
        if (r == 2) CONFORM_NOTE("gloss", what, off[1]);        /* the edge lies where the field is interpolated */
        else CONFORM_MAX("gloss", what, 0.05, off[1]);
    }
    sfield_scene_free(s);
    sfield_free(f);
    model_free(&m);
}

/* Products of texels and of coefficients, with a cache and without; rgb is what it is without gloss; points that are
   not in view get 0. */
static void wavelets_with_gloss_agree(void **state)
{
    enum { COUNT = 40 };
    static const uint8_t seen[COUNT] = { 1, 0, 1, 1 };
    float rgb[5][3 * COUNT], gloss[5][3 * COUNT], ambient[2][COUNT];
    sfield_desc d = small_desc(SFIELD_BASIS_HAAR);
    sfield_field *f;
    uint64_t seed = 14, products[2] = { 0, 0 };
    eye e[COUNT];
    (void)state;
    d.cube_side = 16;
    f = field_of_sphere(&d);
    for (int i = 0; i < COUNT; i++) {
        e[i] = eye_at(0.2 + 0.7 * rnd(&seed), 0.8f, 0.5f, rnd_in(&seed, 0.1, 1));
        e[i].exponent = 20;
        e[i].p[0] = rnd_in(&seed, -3, 3);
        e[i].p[2] = rnd_in(&seed, -3, 3);
    }
    for (int k = 0; k < 5; k++) {           /* Phong: texels, coefficients, a cache, no gloss; some not in view */
        sfield_scene_desc scene;
        sfield_scene *s = NULL;
        sfield_scene_stats stats;
        sfield_entity ball = upright;
        sfield_points set;
        memset(&scene, 0, sizeof scene);
        memset(&set, 0, sizeof set);
        scene.basis = SFIELD_BASIS_HAAR;
        scene.cube_side = 16;
        scene.product = k == 1 ? SFIELD_PRODUCT_SPARSE : SFIELD_PRODUCT_TEXELS;
        assert_int_equal(sfield_scene_create(&scene, &s), SFIELD_OK);
        ball.occlusion = f;
        ball.transform[13] = 1.5f;
        assert_int_equal(sfield_scene_entities(s, &ball, 1), SFIELD_OK);
        random_sky(s, 5);
        set.count = COUNT;
        set.positions = e->p;
        set.normals = e->n;
        set.to_eye = e->v;
        set.exponents = &e->exponent;
        set.position_stride = set.normal_stride = set.to_eye_stride = set.exponent_stride = sizeof *e;
        set.rgb = rgb[k];
        set.gloss = k == 3 ? NULL : gloss[k];
        set.ambient = k == 0 ? ambient[0] : k == 3 ? ambient[1] : NULL;
        set.in_view = k == 4 ? seen : NULL;
        if (k == 2) assert_int_equal(sfield_cache_create(s, COUNT, 1, &set.cache), SFIELD_OK);
        assert_int_equal(sfield_shade(s, &set, 1, &stats), SFIELD_OK);
        if (k == 0 || k == 3) products[k / 3] = stats.products;
        if (k == 2) {
            assert_int_equal(sfield_shade(s, &set, 1, &stats), SFIELD_OK);
            assert_int_equal(stats.reused, COUNT);
        }
        sfield_cache_free(set.cache);
        sfield_scene_free(s);
    }
    for (int i = 0; i < 3 * COUNT; i++) {
        assert_true(gloss[0][i] > 0 && fabsf(gloss[1][i] - gloss[0][i]) < 1e-4f);
        assert_true(fabsf(rgb[1][i] - rgb[0][i]) < 1e-4f && fabsf(rgb[3][i] - rgb[0][i]) < 1e-5f);
        assert_true(fabsf(ambient[1][i / 3] - ambient[0][i / 3]) < 1e-5f);
        assert_true(gloss[4][i] >= (seen[i / 3] ? gloss[0][i] : 0) && gloss[4][i] <= (seen[i / 3] ? gloss[0][i] : 0));
    }
    for (int i = 0; i < 3 * COUNT; i++)         /* 256 of 1,536 wavelets are kept */
        assert_true(fabsf(gloss[2][i] - gloss[0][i]) < 0.02f * gloss[0][i] + 1e-3f);
    assert_int_equal(products[0], products[1]);
    assert_true(products[0] > COUNT / 2);
    sfield_free(f);
}

/* What a cache kept, what a fresh one computes, and what none does. */
typedef struct kept { float rgb[3 * 40], ambient[40], gloss[3 * 40], grazing[3 * 40]; } kept;

static sfield_scene_stats shade_kept(sfield_scene *s, const sfield_points *set, sfield_cache *cache, kept *out)
{
    sfield_points now = *set;
    sfield_scene_stats stats;
    memset(out, 0, sizeof *out);
    now.rgb = set->rgb ? out->rgb : NULL;
    now.ambient = set->ambient ? out->ambient : NULL;
    now.gloss = set->gloss ? out->gloss : NULL;
    now.grazing = set->grazing ? out->grazing : NULL;
    now.cache = cache;
    assert_int_equal(sfield_shade(s, &now, 1, &stats), SFIELD_OK);
    return stats;
}

/* A lamp, a sky and two bodies over points that somebody looks at; the field of the lamp is *source. */
static sfield_scene *kept_scene(sfield_scene_desc d, sfield_field **body, sfield_field **source, sfield_entity at[4])
{
    sfield_desc field = small_desc(d.basis);
    sfield_emitter glow;
    sfield_scene *s = NULL;
    memset(&glow, 0, sizeof glow);
    glow.radius = 0.3f;
    for (int k = 0; k < 3; k++) glow.radiance[k] = 20;
    field.logarithm = d.product == SFIELD_PRODUCT_EXP;
    *body = field_of_sphere(&field);
    field.logarithm = 0;
    assert_int_equal(sfield_build_emitter(&field, &glow, source, NULL), SFIELD_OK);
    assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
    random_sky(s, 5);
    for (int i = 0; i < 4; i++) at[i] = upright;
    at[0].occlusion = at[1].occlusion = *body;
    at[2].source = at[3].source = *source;
    at[0].transform[13] = 4;
    at[1].transform[13] = 500;                  /* out of reach */
    at[2].transform[12] = 3;                    /* beside the bodies and near: nothing hides it */
    at[2].transform[13] = 1;
    at[3].transform[13] = 30;                   /* behind the body, as is the sky */
    assert_int_equal(sfield_scene_entities(s, at, 4), SFIELD_OK);
    return s;
}

/* Frame by frame: what happens, and of three lights how many of each point are kept; -1: not the same of all. */
static const struct { char what; int kept; } frames_of_gloss[] = {
    { ' ', 0 }, { ' ', 3 }, { 'f', 3 },         /* another body moves far off */
    { 'b', 1 }, { ' ', 3 },                     /* the body moves: the lamp before it is kept */
    { 't', 3 }, { 's', 3 },                     /* a tint; the sky, by the same T */
    { 'e', -1 }, { ' ', 3 }, { 'm', -1 },       /* an eye moves, a material or exponent changes */
    { 'v', -1 }, { ' ', -1 }, { 'a', -1 },      /* points out of view; all again */
    { 'n', 0 }, { 'g', 0 }, { ' ', 3 },         /* no gloss, gloss again */
};

static void change_frame(char what, sfield_scene *s, sfield_entity at[4], eye *e, sfield_points *set, float *any)
{
    static uint8_t seen[40];
    if (what == 'f') at[1].transform[12] += 5;
    if (what == 'b') at[0].transform[12] += 0.01f;
    if (what == 't') at[2].tint[1] = 2;
    if (what == 's') random_sky(s, 9);
    if (what == 'e') e[3].v[0] = -e[3].v[0];
    if (what == 'm') {
        e[20].exponent += 3;
        e[20].material[4] = 0.77f;
    }
    for (int i = 0; i < 40; i++) seen[i] = (uint8_t)(i % 3 > 0);
    if (what == 'v') set->in_view = seen;
    if (what == 'a') set->in_view = NULL;
    if (what == 'n') set->gloss = NULL;
    if (what == 'g') set->gloss = any;
    assert_int_equal(sfield_scene_entities(s, at, 4), SFIELD_OK);
}

/* Results that are kept equal those of a fresh cache to the bit, whatever moves or is looked at from elsewhere, and
   those of no cache but for 16 bits (harmonics) or 256 wavelets. Each light's T is kept as that of diffuse points. */
static void gloss_is_kept_as_what_is_diffuse(void **state)
{
    enum { COUNT = 40, FRAMES = sizeof frames_of_gloss / sizeof *frames_of_gloss };
    static eye e[COUNT];
    static kept lazy, fresh, plain;
    float any[3];
    (void)state;
    for (int way = 0; way < 8; way++) {         /* a lobe or materials; both bases, two products each */
        static const sfield_product_mode products[4] = { SFIELD_PRODUCT_TRIPLE, SFIELD_PRODUCT_EXP,
                                                         SFIELD_PRODUCT_TEXELS, SFIELD_PRODUCT_SPARSE };
        const int materials = way & 1;
        sfield_field *body, *source;
        sfield_cache *cache = NULL, *own = NULL;
        sfield_entity at[4];
        sfield_scene_desc d;
        sfield_scene *s;
        sfield_points set;
        uint64_t seed = 14;
        double worst = 0, most = 0;
        size_t bytes;
        memset(&d, 0, sizeof d);
        memset(&set, 0, sizeof set);
        d.product = products[way / 2];
        d.basis = way < 4 ? SFIELD_BASIS_SH : SFIELD_BASIS_HAAR;
        d.cube_side = 8;
        s = kept_scene(d, &body, &source, at);
        for (int i = 0; i < COUNT; i++) {
            e[i] = eye_at(0.3 + 0.6 * rnd(&seed), 0.8f, 0.5f, rnd_in(&seed, 0.3, 1));
            e[i].exponent = rnd_in(&seed, 2, 9);
            e[i].p[0] = rnd_in(&seed, -0.2, 0.2);
            e[i].p[2] = rnd_in(&seed, -0.2, 0.2);
        }
        set.count = COUNT;
        set.positions = e->p;
        set.normals = e->n;
        set.to_eye = e->v;
        if (materials) set.materials = e->material;
        else set.exponents = &e->exponent;
        set.position_stride = set.normal_stride = set.to_eye_stride = sizeof *e;
        set.exponent_stride = set.material_stride = sizeof *e;
        set.rgb = set.gloss = any;
        if (materials) set.grazing = any;
        else set.ambient = any;
        assert_int_equal(sfield_cache_create(s, COUNT, 3, &cache), SFIELD_OK);
        bytes = sfield_cache_bytes(cache);
        for (int f = 0; f < FRAMES; f++) {
            sfield_scene_stats stats;
            change_frame(frames_of_gloss[f].what, s, at, e, &set, any);
            stats = shade_kept(s, &set, cache, &lazy);
            if (frames_of_gloss[f].kept >= 0 && stats.reused != (uint64_t)frames_of_gloss[f].kept * COUNT)
                fail_msg("way %d, frame %d: %d reused", way, f, (int)stats.reused);
            if (strchr("em", frames_of_gloss[f].what) && frames_of_gloss[f].what != ' ')    /* of a tile, of a point */
                assert_int_equal(stats.reused, 3 * (COUNT - (way >= 4 ? 1 : 16)));
            assert_int_equal(sfield_cache_create(s, COUNT, 3, &own), SFIELD_OK);
            (void)shade_kept(s, &set, own, &fresh);
            sfield_cache_free(own);
            if (memcmp(&lazy, &fresh, sizeof lazy) != 0) fail_msg("way %d, frame %d: not as a fresh cache's", way, f);
            (void)shade_kept(s, &set, NULL, &plain);
            for (int i = 0; i < 3 * COUNT && set.gloss; i++) {
                worst = fmax(worst, fabs((double)lazy.gloss[i] - (double)plain.gloss[i]));
                worst = fmax(worst, fabs((double)lazy.grazing[i] - (double)plain.grazing[i]));
                most = fmax(most, (double)plain.gloss[i]);
            }
        }
        assert_true(sfield_cache_bytes(cache) > bytes * (materials ? 2 : 3) / 2);
        print_message("way %d: off by %.2e of %.2e\n", way, worst, most);
        assert_true(most > 0.1 && worst < (way < 4 ? 2e-4 : 0.02) * most);
        sfield_cache_free(cache);
        sfield_scene_free(s);
        sfield_free(body);
        sfield_free(source);
    }
}

/* T of an earlier sky gives the closed form under a sky of 1: the albedo of roughness 1, 1 - v ln((1 + v) / v). */
static void what_is_kept_has_the_albedo_of_the_closed_form(void **state)
{
    double worst[2] = { 0, 0 };
    (void)state;
    for (int b = 0; b < 2; b++) {
        enum { COUNT = 16 };
        float rgb[3 * COUNT], gloss[3 * COUNT];
        sfield_scene_stats stats;
        sfield_scene_desc d;
        sfield_scene *s = NULL;
        sfield_points set;
        eye e[COUNT];
        memset(&d, 0, sizeof d);
        memset(&set, 0, sizeof set);
        d.basis = b ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH;
        assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
        random_sky(s, 5);
        for (int i = 0; i < COUNT; i++) e[i] = eye_at(0.1 + 0.9 * i / COUNT, 1, 1, 1);
        set.count = COUNT;
        set.positions = e->p;
        set.normals = e->n;
        set.to_eye = e->v;
        set.materials = e->material;
        set.position_stride = set.normal_stride = set.to_eye_stride = set.material_stride = sizeof *e;
        set.rgb = rgb;
        set.gloss = gloss;
        assert_int_equal(sfield_cache_create(s, COUNT, 1, &set.cache), SFIELD_OK);
        assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
        assert_int_equal(sfield_scene_environment(s, white, 1, 1, NULL), SFIELD_OK);
        assert_int_equal(sfield_shade(s, &set, 1, &stats), SFIELD_OK);
        assert_int_equal(stats.reused, COUNT);
        for (int i = 0; i < COUNT; i++) {
            const double v = (double)e[i].v[1], albedo = 1 - v * log((1 + v) / v);
            worst[b] = fmax(worst[b], fabs((double)gloss[3 * i] - albedo));
        }
        sfield_cache_free(set.cache);
        sfield_scene_free(s);
    }
    CONFORM_MAX("gloss", "albedo of roughness 1 by a T that was kept under another sky", 0.002, worst[0]);
    CONFORM_MAX("gloss", "the same kept in wavelets", 0.01, worst[1]);
}

/* f(l, v) = f(v, l): what a sky of green sends to an eye that counts by red is what red sends to one that counts by
   green, over all eyes by their cosine. */
static void the_brdf_is_reciprocal(void **state)
{
    enum { SIDE = 48 };
    static eye e[SIDE * SIDE];
    static float rgb[3 * SIDE * SIDE], gloss[3 * SIDE * SIDE];
    static const float rough[3] = { 0.15f, 0.5f, 0.9f };
    sfield_scene *s = scene_of(0);
    float map[3 * 8 * 4] = { 0 }, sky[48];
    double worst = 0;
    (void)state;
    map[3 * 9] = 10;                /* red from one side, green from another and lower */
    map[3 * 14 + 1] = 10;
    map[3 * 21 + 1] = 10;
    assert_int_equal(sfield_scene_environment(s, map, 8, 4, NULL), SFIELD_OK);
    assert_int_equal(sfield_scene_sky(s, sky), SFIELD_OK);
    for (int r = 0; r < 3; r++) {
        double sum[2][2] = { { 0, 0 }, { 0, 0 } };
        for (int i = 0; i < SIDE * SIDE; i++) {
            const double c = sqrt((i / SIDE + 0.5) / SIDE), phi = 2 * PI * (i % SIDE + 0.5) / SIDE;
            e[i] = eye_at(c, 1, 0, rough[r]);
            e[i].v[0] = (float)(sqrt(1 - c * c) * cos(phi));
            e[i].v[2] = (float)(sqrt(1 - c * c) * sin(phi));
        }
        shade_eyes(s, e, SIDE * SIDE, rgb, gloss);
        for (int i = 0; i < SIDE * SIDE; i++) {
            const double v[3] = { (double)e[i].v[0], (double)e[i].v[1], (double)e[i].v[2] };
            for (int k = 0; k < 2; k++) {
                sum[0][k] += sh_value(4, sky + 16 * k, v) * (double)rgb[3 * i + 1 - k];
                sum[1][k] += sh_value(4, sky + 16 * k, v) * (double)gloss[3 * i + 1 - k];
            }
        }
        for (int q = 0; q < 2; q++)
            worst = fmax(worst, fabs(sum[q][0] - sum[q][1]) / fmax(fabs(sum[q][0]), fabs(sum[q][1])));
    }
    CONFORM_MAX("gloss", "metal-rough: light and eye change places, relative", 0.01, worst);
    sfield_scene_free(s);
}

/* A self-visibility of nothing hidden is the cosine: a product with it is what the kernel with its cosine is. */
static void self_visibility_brings_the_cosine(void **state)
{
    enum { COUNT = 32 };
    static const float corners[] = { 0, -9, 0, 1, -9, 0, 0, -9, 1 };
    static const uint32_t triangle[] = { 0, 1, 2 };
    float rgb[2][3 * COUNT], gloss[2][3 * COUNT];
    double sum[2] = { 0, 0 }, off[2] = { 0, 0 };
    sfield_scene *s = scene_of(0);
    sfield_mesh mesh;
    sfield_points set;
    sfield_field *self = NULL;
    uint64_t seed = 8;
    eye e[COUNT];
    (void)state;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = corners;
    mesh.vertex_count = 3;
    mesh.indices = triangle;
    mesh.index_count = 3;
    random_sky(s, 4);
    for (int i = 0; i < COUNT; i++) {
        e[i] = eye_at(0.1 + 0.8 * rnd(&seed), 0.7f, i % 2 ? 1.0f : 0.0f, rnd_in(&seed, 0.3, 1));
        e[i].p[0] = (float)i;
    }
    memset(&set, 0, sizeof set);
    set.count = COUNT;
    set.positions = e->p;
    set.normals = e->n;
    set.to_eye = e->v;
    set.materials = e->material;
    set.position_stride = set.normal_stride = set.to_eye_stride = set.material_stride = sizeof *e;
    assert_int_equal(sfield_build_self(NULL, &mesh, &set, 0.01f, &self, NULL), SFIELD_OK);
    for (int k = 0; k < 2; k++) {
        set.self = k ? self : NULL;
        set.rgb = rgb[k];
        set.gloss = gloss[k];
        assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
    }
    for (int i = 0; i < 3 * COUNT; i++)
        for (int k = 0; k < 2; k++) {
            const double a = (double)(k ? gloss : rgb)[0][i], b = (double)(k ? gloss : rgb)[1][i];
            sum[k] += a * a;
            off[k] += (a - b) * (a - b);
        }
    CONFORM_MAX("gloss", "metal-rough, diffuse: self-visibility of nothing hidden", 0.02, sqrt(off[0] / sum[0]));
    CONFORM_MAX("gloss", "metal-rough, specular: self-visibility of nothing hidden", 0.08, sqrt(off[1] / sum[1]));
    sfield_free(self);
    sfield_scene_free(s);
}

/* What F0 does not color lets any base colour be laid over the results of another. */
static void textures_color_what_is_shaded(void **state)
{
    enum { COUNT = 20 };
    float sky[48], rgb[2][3 * COUNT], gloss[2][3 * COUNT], grazing[3 * COUNT];
    sfield_scene *scenes[2];
    uint64_t seed = 77;
    eye e[COUNT];
    (void)state;
    scenes[0] = scene_of(0);
    random_sky(scenes[0], 3);
    scenes[1] = wavelets_under(sky);
    for (int b = 0; b < 2; b++) {
        sfield_points set;
        memset(&set, 0, sizeof set);
        for (int i = 0; i < COUNT; i++) {
            e[i] = random_eye(&seed);
            e[i].material[3] = i % 2 ? 1.0f : 0.4f;
        }
        shade_eyes(scenes[b], e, COUNT, rgb[0], gloss[0]);
        set.count = COUNT;
        set.positions = e->p;
        set.normals = e->n;
        set.to_eye = e->v;
        set.position_stride = set.normal_stride = set.to_eye_stride = set.material_stride = sizeof *e;
        set.rgb = rgb[1];
        set.gloss = gloss[1];
        set.grazing = grazing;
        grazing[5] = 3;
        assert_int_equal(sfield_shade(scenes[b], &set, 1, NULL), SFIELD_OK);
        assert_true(grazing[5] >= 0 && grazing[5] <= 0);        /* no materials, none of this */
        set.materials = e->material;
        for (int i = 0; i < COUNT; i++) e[i].material[3] = 0;   /* without metal F0 is 0.04 */
        assert_int_equal(sfield_shade(scenes[b], &set, 1, NULL), SFIELD_OK);
        for (int i = 0; i < 3 * COUNT; i++) {
            const float metallic = i / 3 % 2 ? 1.0f : 0.4f, f0 = 0.04f + metallic * (e[i / 3].material[i % 3] - 0.04f);
            const float laid = (gloss[1][i] - grazing[i]) * f0 / 0.04f + grazing[i];
            assert_true(fabsf(laid - gloss[0][i]) < 1e-4f * (1 + fabsf(gloss[0][i])));
            assert_true(fabsf(rgb[1][i] * (1 - f0) / 0.96f - rgb[0][i]) < 1e-4f);
        }
        sfield_scene_free(scenes[b]);
    }
}

/* From the last task to the first: what is computed does not depend on it. */
static void backwards(void *user, size_t count, sfield_task task, void *context)
{
    (void)user;
    while (count-- > 0) task(context, count);
}

static void materials_do_not_depend_on_threads(void **state)
{
    enum { COUNT = 96 };
    float rgb[2][3 * COUNT], gloss[2][3 * COUNT];
    uint64_t seed = 2;
    eye e[COUNT];
    (void)state;
    for (int i = 0; i < COUNT; i++) e[i] = random_eye(&seed);
    for (int k = 0; k < 2; k++) {
        sfield_scene_desc d;
        sfield_scene *s = NULL;
        memset(&d, 0, sizeof d);
        d.system.parallel_for = k ? backwards : NULL;
        assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
        random_sky(s, 6);
        shade_eyes(s, e, COUNT, rgb[k], gloss[k]);
        sfield_scene_free(s);
    }
    assert_memory_equal(rgb[0], rgb[1], sizeof rgb[0]);
    assert_memory_equal(gloss[0], gloss[1], sizeof gloss[0]);
}

typedef struct notes { char line[200]; int count; } notes;

static void note(void *user, const char *message)
{
    notes *n = (notes *)user;
    snprintf(n->line, sizeof n->line, "%s", message);
    n->count++;
}

static void bad_materials_are_refused(void **state)
{
    static const struct { sfield_result result; const char *line; } bad[] = {
        { SFIELD_ERR_ARGUMENT, "points->exponents is there beside materials" },
        { SFIELD_ERR_ARGUMENT, "points->to_eye is NULL, but gloss and materials are there" },
        { SFIELD_ERR_ARGUMENT, "points->ambient is there beside gloss and materials, which have none" },
        { SFIELD_ERR_ARGUMENT, "points->material_stride is 16; it must be 0, or a multiple of 4 of at least 20" },
        { SFIELD_ERR_INPUT, "points->materials[1] has the base colour 1.5; it must be 0..1" },
        { SFIELD_ERR_INPUT, "points->materials[1] has the metallic -0.5; it must be 0..1" },
        { SFIELD_ERR_INPUT, "points->materials[1] has the roughness 2; it must be 0..1" },
        { SFIELD_ERR_INPUT, "points->to_eye[0] has the length 2; it must be 1 (0.97..1.03), or 0" },
    };
    sfield_scene_desc d;
    sfield_scene *s = NULL;
    notes n = { "", 0 };
    float out[6], ambient[2];
    (void)state;
    memset(&d, 0, sizeof d);
    d.system.log = note;
    d.system.user = &n;
    assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
    for (int i = -1; i < 8; i++) {
        char line[200];
        eye e[2] = { eye_at(0.5, 1, 0, 0.5f), eye_at(0.5, 1, 0, 0.5f) };
        sfield_points set;
        memset(&set, 0, sizeof set);
        set.count = 2;
        set.positions = e->p;
        set.normals = e->n;
        set.to_eye = e->v;
        set.materials = e->material;
        set.position_stride = set.normal_stride = set.to_eye_stride = set.material_stride = sizeof *e;
        set.gloss = out;
        if (i == 0) set.exponents = out;
        if (i == 1) set.to_eye = NULL;
        if (i == 2) set.ambient = ambient;
        if (i == 3) set.material_stride = 16;
        if (i == 4) e[1].material[2] = 1.5f;
        if (i == 5) e[1].material[3] = -0.5f;
        if (i == 6) e[1].material[4] = 2;
        if (i == 7) e[0].v[0] = 0, e[0].v[1] = 2;
        assert_int_equal(sfield_shade(s, &set, 1, NULL), i < 0 ? SFIELD_OK : bad[i].result);
        if (i < 0) continue;
        snprintf(line, sizeof line, "sfield_shade: %s", bad[i].line);
        assert_string_equal(n.line, line);
        assert_int_equal(n.count, i + 1);
        set.gloss = NULL;           /* what only gloss needs is not looked at without */
        if (i > 3 && i < 7) assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
    }
    sfield_scene_free(s);
}

static void every_allocation_may_fail(void **state)
{
    const eye e = eye_at(0.5, 1, 0, 0.5f);
    size_t fail;
    int failed = 1;
    (void)state;
    for (fail = 1; failed; fail++) {
        counting c = { 0, 0, 0, 0, 0 };
        sfield_scene_desc d;
        sfield_scene *s = NULL;
        sfield_points set;
        float out[3] = { 7, 7, 7 };
        memset(&d, 0, sizeof d);
        memset(&set, 0, sizeof set);
        d.system.allocator = counting_allocator(&c);
        assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
        set.count = 1;
        set.positions = e.p;
        set.normals = e.n;
        set.to_eye = e.v;
        set.materials = e.material;
        set.gloss = out;
        assert_int_equal(sfield_cache_create(s, 1, 2, &set.cache), SFIELD_OK);
        c.calls = 0;
        c.fail_at = fail;
        failed = sfield_shade(s, &set, 1, NULL) != SFIELD_OK;
        assert_true(!failed || (out[0] >= 7 && out[0] <= 7));
        c.fail_at = 0;
        assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
        assert_true(fabsf(out[0]) < 1);
        sfield_cache_free(set.cache);
        sfield_scene_free(s);
        assert_int_equal(c.now, 0);
    }
    assert_int_equal(fail - 1, 4);      /* the cache, the table and the scratch, then none fails */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(albedos_are_closed_forms),
        cmocka_unit_test(known_lights_are_integrated),
        cmocka_unit_test(spheres_hide_as_for_a_path_tracer),
        cmocka_unit_test(wavelets_have_both_brdfs),
        cmocka_unit_test(eyes_below_the_horizon_look_along_it),
        cmocka_unit_test(wavelets_hide_as_for_a_path_tracer),
        cmocka_unit_test(wavelets_with_gloss_agree),
        cmocka_unit_test(gloss_is_kept_as_what_is_diffuse),
        cmocka_unit_test(what_is_kept_has_the_albedo_of_the_closed_form),
        cmocka_unit_test(the_brdf_is_reciprocal),
        cmocka_unit_test(self_visibility_brings_the_cosine),
        cmocka_unit_test(textures_color_what_is_shaded),
        cmocka_unit_test(materials_do_not_depend_on_threads),
        cmocka_unit_test(bad_materials_are_refused),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
