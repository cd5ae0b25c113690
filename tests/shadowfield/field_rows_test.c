/* field_rows_test - fields of shadowfield.h against spheres in closed form and against brute force: rows T14, T72 to
   T77 and T81 (budgets) of docs/conformance.md. */
#define SFIELD_STATIC
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include "conformance.h"

static double share_hidden(const sfield_field *f, double d, const double *dir)
{
    float p[3], out[64];
    int k;
    for (k = 0; k < 3; k++) p[k] = (float)(d * dir[k]);
    assert_int_equal(sfield_query(f, 1, p, 0, out), SFIELD_OK);
    return 1 - (double)out[0] / sqrt(4 * PI);
}

static void t72_a_sphere_hides_its_solid_angle(void **state)
{
    static const double at[4] = { 1.25, 2, 8, 20 }, exact[4] = { 0.20000, 0.06699, 0.00392, 0.000625 };
    static const char *const names[4] = { "percent blocked 1.25 r away, shadow field", "2 r away, shadow field",
                                          "8 r away, shadow field", "20 r away, shadow field" };
    sfield_desc desc;
    sfield_field *f;
    sfield_info info;
    double d, dir[3];
    float c[16], p[3] = { 2, 0, 0 };
    uint64_t seed = 1;
    int k;
    (void)state;
    memset(&desc, 0, sizeof desc);
    f = field_of_sphere(&desc);
    sfield_get_info(f, &info);
    print_message("T72: default field %lu bytes, inscribed sphere %.4f\n", (unsigned long)info.bytes,
                  (double)info.inscribed);
    assert_true(info.sample_count == 16 * 6 * 9 && info.bytes == 16 * info.sample_count + 2240);
    assert_true(info.inscribed > 0.99f && info.inscribed <= 1);
    for (k = 0; k < 4; k++) {
        rnd_direction(&seed, dir);
        d = share_hidden(f, at[k], dir);
        CONFORM("T72", names[k], 100 * exact[k], 100 * d, 2 * exact[k]);  /* between shells within 2 % */
    }
    sfield_query(f, 1, p, 0, c);
    assert_true(fabs((double)c[0] - 3.307444) < 0.02 * (3.544908 - 3.307444));
    sfield_free(f);
}

/* Irradiance of a receiver that faces the light, from texels. */
static double facing(const sfield_field *f, double d)
{
    static float texels[3 * 6144];
    float p[3] = { 0, 0, 0 }, dir[3];
    double sum = 0;
    uint32_t i;
    p[2] = (float)-d;
    assert_int_equal(sfield_query(f, 1, p, 0, texels), SFIELD_OK);
    for (i = 0; i < 6144; i++) {
        double a = (double)sfield_cube_texel(32, i, dir);
        if (dir[2] > 0) sum += (double)texels[i] * (double)dir[2] * a;
    }
    return sum;
}

static void t73_a_sphere_lights_as_in_closed_form(void **state)
{
    static const double at[3] = { 2, 8, 20 }, exact[3] = { 0.785398, 0.049087, 0.007854 };
    static const char *const names[3] = { "irradiance facing a sphere's source field 2 r away", "8 r away",
                                          "20 r away" };
    sfield_emitter light;
    sfield_desc desc;
    sfield_field *f, *sh;
    float p[3] = { 0, 0, -4 }, c[48];
    double cosine = sqrt(1 - 1.0 / 16);
    int k;
    (void)state;
    memset(&light, 0, sizeof light);
    memset(&desc, 0, sizeof desc);
    light.radius = 0.5f;                                              /* r is then the light's radius */
    light.radiance[0] = 1;
    light.radiance[1] = 2;
    desc.basis = SFIELD_BASIS_HAAR;
    desc.shell_count = 8;
    desc.position_side = 3;
    desc.shell_count = 12;
    desc.inner = 1.2f;
    desc.keep = 0.2f;
    assert_int_equal(sfield_build_emitter(&desc, &light, &f, NULL), SFIELD_OK);
    for (k = 0; k < 3; k++) {
        double e = facing(f, 0.5 * at[k]);
        CONFORM("T73", names[k], exact[k], e, 0.02 * exact[k]);           /* texels of 32 x 32 */
    }
    sfield_free(f);
    memset(&desc, 0, sizeof desc); /* harmonics: a cap's coefficients in closed form */
    desc.position_side = 5;
    assert_int_equal(sfield_build_emitter(&desc, &light, &sh, NULL), SFIELD_OK);
    p[2] = -2;
    sfield_query(sh, 1, p, 0, c);
    assert_true(fabs((double)c[0] / (sqrt(PI) * (1 - cosine)) - 1) < 0.02);
    assert_true(fabs((double)c[2] / (0.5 * sqrt(3 * PI) * (1 - cosine * cosine)) - 1) < 0.02);
    assert_true(fabsf(c[16] - 2 * c[0]) < 0.01f && fabsf(c[32]) < 1e-6f);
    sfield_free(sh);
}

/* Irradiance of a point h away from the middle of a tube's axis, facing it: of a line of length 2 a and radiance times
   diameter 1; of the side of a cylinder of radius r and radiance 1, a configuration factor (Hamilton and Morgan 1952)
   for each half. */
static double line_facing(double a, double h)
{
    const double t = atan(a / h);
    return (t + sin(t) * cos(t)) / h;
}

static double cylinder_facing(double a, double r, double h)
{
    const double l = a / r, n = h / r, x = (1 + n) * (1 + n) + l * l, y = (1 - n) * (1 - n) + l * l;
    return 2 * (atan(l / sqrt(n * n - 1)) / n + l * (x - 2 * n) / (n * sqrt(x * y)) *
                                                    atan(sqrt(x * (n - 1) / (y * (n + 1)))) -
                l / n * atan(sqrt((n - 1) / (n + 1))));
}

/* The same by sums over the cylinder, so that the formula above is known to be right. */
static double cylinder_sum(double a, double r, double h)
{
    double sum = 0;
    int i, j;
    for (i = 0; i < 1000; i++)
        for (j = 0; j < 1000; j++) {
            const double x = a * ((i + 0.5) / 500 - 1), phi = PI * ((j + 0.5) / 500 - 1);
            const double z = h - r * cos(phi), y = r * sin(phi), d2 = x * x + y * y + z * z;
            const double out = z * cos(phi) - y * sin(phi);           /* towards the point, times the distance */
            if (out > 0) sum += out * z / (d2 * d2) * (2 * a / 1000) * (2 * PI * r / 1000);
        }
    return sum;
}

static sfield_emitter tube_of(sfield_emitter_kind kind, double a, double r)
{
    sfield_emitter e;
    memset(&e, 0, sizeof e);
    e.kind = kind;
    e.u[0] = (float)(0.6 * a);
    e.u[1] = (float)(0.8 * a);
    e.radius = (float)r;
    e.radiance[0] = 1;
    e.radiance[2] = 0.5f;
    return e;
}

/* Half length 0.5. In harmonics that is what the second band says: all light comes from before the point. */
static void lines_and_cylinders_light_as_in_closed_form(void **state)
{
    static const double at[3] = { 0.6, 1.5, 5 }, radii[2] = { 0.005, 0.2 };
    static const char *const names[3] = { "a line", "a cylinder of radius 0.005", "a cylinder of radius 0.2" };
    char name[80];
    int kind, basis, k;
    (void)state;
    assert_true(fabs(cylinder_facing(0.5, 0.2, 0.6) / cylinder_sum(0.5, 0.2, 0.6) - 1) < 1e-4);
    assert_true(fabs(cylinder_facing(0.5, 1e-4, 1.5) / 2e-4 / line_facing(0.5, 1.5) - 1) < 1e-3);
    for (kind = 0; kind < 3; kind++)
        for (basis = 0; basis < 2; basis++) {
            const double r = kind ? radii[kind - 1] : 0;
            const sfield_emitter e = tube_of(kind ? SFIELD_EMITTER_CYLINDER : SFIELD_EMITTER_LINE, 0.5, r);
            sfield_desc desc;
            sfield_field *f;
            memset(&desc, 0, sizeof desc);
            desc.basis = basis ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH;
            desc.shell_count = 12;
            desc.position_side = 9;
            desc.inner = 1.1f;
            desc.outer = 12;
            desc.keep = 0.2f;
            assert_int_equal(sfield_build_emitter(&desc, &e, &f, NULL), SFIELD_OK);
            for (k = 0; k < 3; k++) {
                const double exact = kind ? cylinder_facing(0.5, r, at[k]) : line_facing(0.5, at[k]);
                float p[3] = { 0, 0, 0 }, c[48];
                double measured;
                p[2] = (float)-at[k];
                if (basis) measured = facing(f, at[k]);
                else {
                    assert_int_equal(sfield_query(f, 1, p, 0, c), SFIELD_OK);
                    measured = (double)c[2] / 0.48860251;
                    assert_true(fabsf(c[34] - 0.5f * c[2]) < 0.01f * c[2] && fabsf(c[18]) < 1e-6f);
                }
                snprintf(name, sizeof name, "facing %s, length 1, %g away, %s", names[kind], at[k],
                         basis ? "wavelets" : "harmonics");
                CONFORM("irradiance", name, exact, measured, 0.015 * exact);            /* between shells */
            }
            sfield_free(f);
        }
}

/* The sum over all directions is the intensity over the square of the distance, seen from far, and nothing end on. A
   normal and cone leave the half of it that goes there; from inside a cylinder shines all round, as a sphere does. */
static void tubes_shine_across_and_keep_to_their_cone(void **state)
{
    const sfield_emitter thin = tube_of(SFIELD_EMITTER_LINE, 0.5, 0);
    sfield_desc desc = small_desc(SFIELD_BASIS_SH);
    sfield_emitter e = thin;
    sfield_field *f;
    float p[12] = { 0, 0, 5, 0, 0, -5, 3, 4, 0, 0.024f, 0.032f, 0 }, c[4 * 48];
    (void)state;
    desc.shell_count = 16;
    desc.position_side = 9;
    desc.inner = 0.01f;
    e.normal[2] = 1;
    assert_int_equal(sfield_build_emitter(&desc, &e, &f, NULL), SFIELD_OK);
    sfield_query(f, 3, p, 0, c);
    assert_true(fabs((double)c[0] * sqrt(4 * PI) / (2 * sin(atan(0.1)) / 5) - 1) < 0.03);
    assert_true(fabsf(c[48]) < 1e-4f * c[0] + 1e-6f && fabsf(c[96]) < 0.2f * c[0]);     /* points 11 degrees apart */
    sfield_free(f);
    e = tube_of(SFIELD_EMITTER_CYLINDER, 0.5, 0.2);
    assert_int_equal(sfield_build_emitter(&desc, &e, &f, NULL), SFIELD_OK);
    sfield_query(f, 4, p, 0, c);
    assert_true(fabs((double)c[144] * sqrt(4 * PI) / (4 * PI) - 1) < 0.02);
    assert_true(fabsf(c[96]) < 0.2f * c[0]);                          /* the open end shows the dark inside */
    sfield_free(f);
}

static void t74_fields_answer_outside_and_inside(void **state)
{
    sfield_desc desc;
    sfield_field *f;
    double dir[3] = { 0.36, 0.48, 0.8 }, a, b;
    float p[3] = { 0, 0, 0 }, c[16];
    int i;
    (void)state;
    memset(&desc, 0, sizeof desc);
    f = field_of_sphere(&desc);
    a = share_hidden(f, 7.9999, dir);
    b = share_hidden(f, 8.0001, dir);
    CONFORM_MAX("T74", "step of the hidden share across the outermost shell", 1e-5, fabs(a - b));
    assert_true(fabs(share_hidden(f, 1e12, dir)) < 1e-6);
    for (i = 0; i < 50; i++) {
        double s = share_hidden(f, 0.02 * i, dir);
        assert_true(s > 0.4 && s < 0.505);                            /* inside: what the surface sees, a half */
    }
    sfield_query(f, 1, p, 0, c);
    for (i = 0; i < 16; i++) assert_true(sfield__finite(c[i]));
    p[1] = NAN;
    sfield_query(f, 1, p, 0, c);
    assert_true(fabsf(c[0] - 3.5449077f) < 1e-6f && c[5] == 0);
    p[1] = INFINITY;
    sfield_query(f, 1, p, 0, c);
    assert_true(fabsf(c[0] - 3.5449077f) < 1e-6f && c[5] == 0);
    sfield_free(f);
    desc.keep_inside = 1;
    desc.shell_count = 8;
    f = field_of_sphere(&desc);
    for (i = 0; i < 50; i++) {
        double s = share_hidden(f, 0.02 * i, dir);
        assert_true(s > 0.6 && s < 1.01);                             /* all is hidden */
    }
    sfield_free(f);
}

static void view_stripes(void *user, float time, const float *p, const float *d, float *rgb)
{
    (void)user;
    (void)time;
    (void)p;
    rgb[0] = d[0] > 0.1f ? 0.9f : d[1] > 0.3f ? 0.5f : 0;
}

static void t77_coefficients_err_by_half_a_step_of_their_range(void **state)
{
    static float exact[6144][16], direct[4096];
    model m = model_soup(12, 0.5, 4);
    sfield_mesh mesh = mesh_of(&m);
    sfield_desc desc;
    sfield_field *f;
    double worst = 0, range[16];
    float low[16], high[16];
    uint32_t i, k, n = 6 * 8 * 8;
    (void)state;
    memset(&desc, 0, sizeof desc);
    desc.shell_count = 2;
    desc.inner = 1.2f;
    desc.outer = 1.5f;
    desc.position_side = 8;
    assert_int_equal(sfield_build(&desc, &mesh, &f, NULL), SFIELD_OK);
    {                                                                 /* the values before they became bytes */
        sfield__build b;
        sfield__read_desc(&b, &desc, SFIELD__KIND_OCCLUSION, "");
        b.what = SFIELD__MESH;
        assert_int_equal(sfield__take_mesh(&b, &mesh), SFIELD_OK);
        assert_int_equal(sfield__prepare_build(&b), SFIELD_OK);
        b.radius = b.radii[0];
        for (i = 0; i < n; i++) {
            float eye[3];
            sfield__sample_point(&b, i, eye);
            sfield__view_from(&b, &b.view[0], eye);
            sfield__encode_sh(&b, &b.view[0], NULL, exact[i]);
        }
        memcpy(direct, b.view[0].texel, 4 * 1536);
        sfield__release_build(&b);
    }
    for (k = 0; k < 16; k++) {
        low[k] = high[k] = exact[0][k];
        for (i = 0; i < n; i++) {
            low[k] = exact[i][k] < low[k] ? exact[i][k] : low[k];
            high[k] = exact[i][k] > high[k] ? exact[i][k] : high[k];
        }
        range[k] = (double)high[k] - (double)low[k];
    }
    for (i = 0; i < n; i++)
        for (k = 0; k < 16; k++) {
            double q = (double)f->scale[k] * f->sample[i * 16 + k] + (double)f->bias[k];
            worst = fmax(worst, fabs(q - (double)exact[i][k]) / (range[k] / 510));
        }
    CONFORM_MAX("T77", "largest error of a coefficient by its range / 510", 1.001, worst);   /* and rounding */
    assert_true(range[15] > 1.2 * range[0] || range[0] > 1.2 * range[15]);
    sfield_free(f);
    model_free(&m);
}

static void a_callback_s_cubes_are_kept_texel_by_texel(void **state)
{
    sfield_desc desc = small_desc(SFIELD_BASIS_HAAR);
    sfield_field *f;
    static float out[6 * 64];
    float p[3] = { 3, 1, 1 }, d[3];
    uint32_t i;
    (void)state;
    desc.radius = 1;
    desc.keep = 1;
    desc.inner = 0.5f;
    desc.outer = 0.9f;                                                /* inside: no direction is left out */
    assert_int_equal(sfield_build_callback(&desc, view_stripes, NULL, &f, NULL), SFIELD_OK);
    p[0] = p[1] = p[2] = 0.3f;
    assert_int_equal(sfield_query(f, 1, p, 0, out), SFIELD_OK);
    for (i = 0; i < 6 * 64; i++) {
        sfield_cube_texel(8, i, d);
        if (fabsf(d[0] - 0.1f) < 0.2f || fabsf(d[1] - 0.3f) < 0.2f) continue;
        assert_true(fabsf(out[i] - (d[0] > 0.1f ? 0.1f : d[1] > 0.3f ? 0.5f : 1)) < 0.01f);
    }
    sfield_free(f);
}

/* What is kept of wavelets at several budgets; everything kept gives the texels back. */
static void t81_more_wavelets_lose_less(void **state)
{
    static const float keeps[4] = { 0.005f, 0.01f, 0.04f, 1 };
    model m = model_soup(40, 0.3, 5);
    sfield_mesh mesh = mesh_of(&m);
    double before = 1;
    int i;
    (void)state;
    for (i = 0; i < 4; i++) {
        sfield_desc desc;
        sfield_stats stats;
        sfield_field *f;
        sfield_info info;
        memset(&desc, 0, sizeof desc);
        desc.basis = SFIELD_BASIS_HAAR;
        desc.shell_count = 4;
        desc.position_side = 3;
        desc.keep = keeps[i];
        assert_int_equal(sfield_build(&desc, &mesh, &f, &stats), SFIELD_OK);
        sfield_get_info(f, &info);
        if (keeps[i] == 0.01f) CONFORM_NOTE("T81", "relative L2 error of 40 triangles where 1 % is kept", stats.lost);
        assert_true(stats.lost < before);
        assert_true(i < 3 || stats.lost == 0);
        assert_true(stats.coefficients == info.coefficient_count && stats.triangles == 40);
        before = stats.lost;
        sfield_free(f);
    }
    assert_true(before < 1e-12);
    model_free(&m);
}

/* Brute force: rays through many samples of a texel, in double. */
static double brute(const model *m, const double *eye, const double *d)
{
    size_t t;
    for (t = 0; t < m->indices; t += 3) {
        double q[3][3], det = 0, e[3];
        uint32_t i, k;
        for (i = 0; i < 3; i++)
            for (k = 0; k < 3; k++) q[i][k] = (double)m->p[3 * m->i[t + i] + k] - eye[k];
        for (i = 0; i < 3; i++) {
            const double *a = q[i], *b = q[(i + 1) % 3];
            e[i] = d[0] * (a[1] * b[2] - a[2] * b[1]) + d[1] * (a[2] * b[0] - a[0] * b[2]) +
                   d[2] * (a[0] * b[1] - a[1] * b[0]);
        }
        det = q[2][0] * (q[0][1] * q[1][2] - q[0][2] * q[1][1]) + q[2][1] * (q[0][2] * q[1][0] - q[0][0] * q[1][2]) +
              q[2][2] * (q[0][0] * q[1][1] - q[0][1] * q[1][0]);
        if (det > 0 ? e[0] >= 0 && e[1] >= 0 && e[2] >= 0 : e[0] <= 0 && e[1] <= 0 && e[2] <= 0) return 1;
    }
    return 0;
}

static void views_see_what_rays_see(void **state)
{
    model m = model_soup(30, 0.4, 6);
    sfield_mesh mesh = mesh_of(&m);
    sfield_desc desc;
    sfield__build b;
    uint64_t seed = 7;
    int round;
    uint32_t i, k, wrong = 0;
    (void)state;
    memset(&desc, 0, sizeof desc);
    desc.radius = 1;
    sfield__read_desc(&b, &desc, SFIELD__KIND_OCCLUSION, "");
    b.what = SFIELD__MESH;
    assert_int_equal(sfield__take_mesh(&b, &mesh), SFIELD_OK);
    assert_int_equal(sfield__prepare_build(&b), SFIELD_OK);
    for (round = 0; round < 6; round++) {
        double dir[3], eye[3];
        float at[3];
        rnd_direction(&seed, dir);
        for (k = 0; k < 3; k++) at[k] = (float)(eye[k] = (double)(float)((round < 3 ? 0.3 : 2.0) * dir[k]));
        sfield__view_from(&b, &b.view[0], at);
        for (i = 0; i < 1536; i++) {
            uint32_t face, x, y, s = b.view[0].scale, hits = 0;
            sfield__texel_place(16, i, &face, &x, &y);
            for (k = 0; k < s * s; k++) {
                double d[3];
                sfield__from_face(face, (2.0 * (x * s + k % s) + 1) / (16 * s) - 1,
                                  (2.0 * (y * s + k / s) + 1) / (16 * s) - 1, d);
                hits += brute(&m, eye, d) > 0;
            }
            wrong += fabs((double)b.view[0].texel[i] * s * s - hits) > 0.5;
        }
    }
    print_message("views: %u of 9216 texels differ from rays in double\n", wrong);
    assert_true(wrong < 6);                                           /* samples on an edge to float precision */
    sfield__release_build(&b);
    model_free(&m);
}

/* ---- positions inside meshes ---- */

/* Positions moved of all; frees the model. */
static uint64_t moved_of(model m, const sfield_desc *desc, uint64_t *all)
{
    sfield_mesh mesh = mesh_of(&m);
    sfield_stats stats;
    sfield_info info;
    sfield_field *f;
    assert_int_equal(sfield_build(desc, &mesh, &f, &stats), SFIELD_OK);
    sfield_get_info(f, &info);
    *all = info.sample_count;
    sfield_free(f);
    model_free(&m);
    return stats.moved;
}

/* Triangles of b behind those of a, turned over or not. */
static model both(model a, model b, int turn)
{
    model m = model_alloc(a.vertices + b.vertices, (a.indices + b.indices) / 3);
    size_t i;
    memcpy(m.p, a.p, 3 * a.vertices * sizeof *m.p);
    memcpy(m.p + 3 * a.vertices, b.p, 3 * b.vertices * sizeof *m.p);
    memcpy(m.i, a.i, a.indices * sizeof *m.i);
    for (i = 0; i < b.indices; i++)
        m.i[a.indices + i] = (uint32_t)a.vertices + b.i[turn ? i / 3 * 3 + (3 - i % 3) % 3 : i];
    model_free(&a);
    model_free(&b);
    return m;
}

static void only_inside_closed_meshes_positions_move(void **state)
{
    sfield_desc desc = small_desc(SFIELD_BASIS_SH);
    uint64_t all, moved, sphere;
    model m;
    (void)state;
    desc.inner = 0.2f;
    desc.outer = 3;
    desc.shell_count = 5;                                                  /* 0.2, 0.39, 0.77, 1.52, 3 */
    desc.position_side = 2;
    desc.radius = 1;
    sphere = moved_of(model_sphere(16, 8, 1), &desc, &all);
    assert_true(sphere == all / 5 * 3);
    desc.keep_inside = 1;
    assert_true(moved_of(model_sphere(16, 8, 1), &desc, &all) == 0);
    desc.keep_inside = 0;
    assert_true(moved_of(model_soup(30, 0.4, 6), &desc, &all) == 0);
    m = model_box(0.55, 0.55, 0.55);
    m.indices -= 6;                                                   /* a cup */
    assert_true(moved_of(m, &desc, &all) == 0);
    m = model_box(0.55, 0.55, 0.55);
    m.indices = 6;                                                    /* a sheet */
    assert_true(moved_of(m, &desc, &all) == 0);
    m = both(model_alloc(0, 0), model_box(0.55, 0.55, 0.55), 1);      /* a room: seen from inside */
    assert_true(moved_of(m, &desc, &all) == 0);
    m = both(model_sphere(16, 8, 1), model_sphere(16, 8, 0.6), 1);  /* a hollow sphere: 0.77 is in its wall */
    assert_true(moved_of(m, &desc, &all) == all / 5);
    m = both(model_sphere(16, 8, 1), model_sphere(16, 8, 0.6), 0);  /* a sphere in a sphere: out of both */
    moved = moved_of(m, &desc, &all);
    assert_true(moved == sphere);
    desc.radius = 1.25f;                                              /* the same positions in a sphere about the bar */
    desc.inner /= desc.radius;
    desc.outer /= desc.radius;
    m = both(model_sphere(16, 8, 1), model_box(0.1, 0.1, 1.2), 0);   /* run through by a bar */
    moved = moved_of(m, &desc, &all);
    assert_true(moved >= sphere && moved < all / 5 * 4);
}

/* A corner of a part that lies in another part: it would see nothing, and darken its triangles where they come out. */
static void points_in_another_part_are_moved_out(void **state)
{
    static const float point[3] = { 0.1f, 0.9f, 0 }, normal[3] = { 1, 0, 0 };
    sfield_desc desc = small_desc(SFIELD_BASIS_SH);
    model m = both(model_box(0.1, 1.2, 0.1), model_sphere(16, 8, 1), 0);
    sfield_mesh mesh = mesh_of(&m);
    sfield_stats stats;
    sfield_field *f;
    float inside[16], outside[16];
    (void)state;
    assert_int_equal(sfield_build_self(&desc, &mesh, AT(point, normal, 1), 1e-3f, &f, &stats), SFIELD_OK);
    assert_int_equal(sfield_self(f, 0, 1, outside), SFIELD_OK);
    assert_true(stats.moved == 1);
    sfield_free(f);
    desc.keep_inside = 1;
    assert_int_equal(sfield_build_self(&desc, &mesh, AT(point, normal, 1), 1e-3f, &f, &stats), SFIELD_OK);
    assert_int_equal(sfield_self(f, 0, 1, inside), SFIELD_OK);
    assert_true(stats.moved == 0 && fabsf(inside[0]) < 1e-3f && outside[0] > 0.2f);   /* PI y00 = 0.89 if open */
    sfield_free(f);
    model_free(&m);
}

/* Share of all directions that a square of half side 1 hides from p, over it by h. */
static double square_hides(double x, double z, double h)
{
    double sum = 0;
    int i;
    for (i = 0; i < 4; i++) {
        double a = i & 1 ? 1 - x : 1 + x, b = i & 2 ? 1 - z : 1 + z;
        sum += atan(a * b / (h * sqrt(a * a + b * b + h * h)));
    }
    return sum / (4 * PI);
}

/* Over a slab, nearer to it than positions are apart: nothing hides light from above, and the slab what it hides. */
static void a_slab_close_by_hides_only_its_own_side(void **state)
{
    static const float height[4] = { 0.002f, 0.01f, 0.05f, 0.2f };
    model m = model_box(1, 0.1, 1);
    sfield_mesh mesh = mesh_of(&m);
    sfield_desc desc;
    sfield_field *f;
    float factors[SFIELD_MAX_BANDS], c[16], p[3], open;
    double y[16], up[3] = { 0, 1, 0 }, least = 1e9, most = 0, wrong = 0;
    int i, k, l;
    (void)state;
    memset(&desc, 0, sizeof desc);
    desc.cube_side = 8;
    desc.position_side = 8;
    desc.outer = 2;
    desc.shell_count = 8;
    sfield_sh_cosine(4, factors);
    sfield_sh_basis(4, up, y);
    assert_int_equal(sfield_build(&desc, &mesh, &f, NULL), SFIELD_OK);
    for (i = 0; i < 24; i++) {
        double light = 0;
        p[0] = 0.3f + 0.06f * (float)(i / 4);                         /* 0.2 r is the innermost shell */
        p[1] = 0.1f + height[i % 4];
        p[2] = 0.05f;
        assert_int_equal(sfield_query(f, 1, p, 0, c), SFIELD_OK);
        for (l = 0, k = 0; l < 4; l++)
            for (; k < (l + 1) * (l + 1); k++) light += (double)(c[k] * factors[l]) * y[k] / PI;
        least = fmin(least, light);
        most = fmax(most, light);
        assert_int_equal(sfield_ambient(f, 1, p, &open), SFIELD_OK);
        wrong = fmax(wrong, fabs((double)open - 1 + square_hides((double)p[0], 0.05, (double)height[i % 4])));
    }
    print_message("over a slab: light %.4f to %.4f of the open sky's, open share %.4f off\n", least, most, wrong);
    assert_true(least > 0.99 && most < 1.02);                         /* 4 bands of half a sphere: up to 1.02 */
    assert_true(wrong < 0.02); /* positions left inside: 0.36, and light of 0.25 */
    sfield_free(f);
    model_free(&m);
}

static void emissive_meshes_shine_outwards_and_by_their_frames(void **state)
{
    model m = model_sphere(24, 12, 1), inside = model_sphere(24, 12, 1);
    sfield_mesh mesh = mesh_of(&m);
    float *radiance = (float *)calloc(3 * m.indices, sizeof(float)), p[3] = { 0, 3, 0 }, c[48], flipped[48];
    sfield_desc desc = small_desc(SFIELD_BASIS_SH);
    sfield_field *f;
    size_t i;
    uint32_t swap;
    (void)state;
    for (i = 0; i < m.indices / 3; i++) radiance[3 * i + 1] = 2;
    desc.inner = 1.2f;
    desc.cube_side = 16;
    desc.frame_count = 2;                                                  /* second frame: twice as bright */
    desc.frames_per_second = 10;
    for (i = 0; i < m.indices / 3; i++) radiance[m.indices + 3 * i + 1] = 4;
    assert_int_equal(sfield_build_emissive(&desc, &mesh, radiance, &f, NULL), SFIELD_OK);
    sfield_query(f, 1, p, 0, c);
    assert_true(c[0] == 0 && fabs((double)c[16] / (2 * sqrt(4 * PI) * blocked(3)) - 1) < 0.05);
    sfield_query(f, 1, p, 0.05f, flipped);
    assert_true(fabsf(flipped[16] / c[16] - 1.5f) < 0.02f);
    sfield_query(f, 1, p, 5, flipped);
    assert_true(fabsf(flipped[16] / c[16] - 2) < 0.02f);
    sfield_query(f, 1, p, -0.15f, flipped);
    assert_memory_equal(flipped, c, sizeof c);
    sfield_free(f);
    desc.loop = 1;                                                    /* from the last frame back to the first */
    assert_int_equal(sfield_build_emissive(&desc, &mesh, radiance, &f, NULL), SFIELD_OK);
    for (i = 0; i < 24; i++) {                                        /* and before time 0 the same */
        static const float bright[4] = { 1, 1.5f, 2, 1.5f };
        sfield_query(f, 1, p, 0.05f * ((float)i - 12), flipped);
        assert_true(fabsf(flipped[16] / c[16] - bright[i % 4]) < 0.02f);
    }
    desc.loop = 0;
    sfield_free(f);
    for (i = 0; i < m.indices; i += 3) {                              /* turned over: shines inwards only */
        swap = m.i[i];
        m.i[i] = m.i[i + 1];
        m.i[i + 1] = swap;
    }
    desc.frame_count = 1;
    assert_int_equal(sfield_build_emissive(&desc, &mesh, radiance, &f, NULL), SFIELD_OK);
    sfield_query(f, 1, p, 0, c);
    assert_true(fabsf(c[16]) < 0.01f);                                /* its far half is hidden by the near one */
    sfield_free(f);
    free(radiance);
    model_free(&m);
    model_free(&inside);
}

/* Sheets that shine red on one side, green on the other: each triangle again the other way round, in each of the three
   ways to write it. What of a position's view they fill is red or green, and as much as they hide. */
static void sheets_that_shine_on_both_sides_shine_as_much_as_they_hide(void **state)
{
    model m = model_soup(30, 0.6, 12), both = model_alloc(m.vertices, 2 * m.indices / 3);
    sfield_mesh mesh = mesh_of(&m), lit = mesh_of(&both);
    float *radiance = (float *)calloc(3 * both.indices / 3, sizeof(float)), p[3 * 32], *c, *open;
    sfield_desc desc = small_desc(SFIELD_BASIS_SH);
    sfield_field *f, *dark;
    sfield_info info;
    double off = 0, most = 0;
    size_t t, i;
    (void)state;
    memcpy(both.p, m.p, 3 * m.vertices * sizeof *m.p);
    for (t = 0; t < m.indices / 3; t++) {
        const uint32_t *from = m.i + 3 * t;
        uint32_t *to = both.i + 6 * t;
        for (i = 0; i < 3; i++) {
            to[i] = from[i];
            to[3 + i] = from[(t + 2 - i) % 3];
        }
        radiance[6 * t] = radiance[6 * t + 4] = 1;
    }
    desc.cube_side = 16;
    desc.position_side = 6;
    assert_int_equal(sfield_build_emissive(&desc, &lit, radiance, &f, NULL), SFIELD_OK);
    assert_int_equal(sfield_build(&desc, &mesh, &dark, NULL), SFIELD_OK);
    sfield_get_info(f, &info);
    for (i = 0; i < 96; i++) {                                        /* where eight samples are one: corners of
                                                                         shells */
        const double d = (double)info.radius * 0.5 * pow(16, (double)(i / 24) / 3) / sqrt(3);
        p[i] = (float)((double)info.center[i % 3] + (i / 3 >> i % 3 & 1 ? d : -d));
    }
    c = (float *)malloc(32 * 48 * sizeof *c);
    open = (float *)malloc(32 * 16 * sizeof *open);
    assert_true(c && open);
    sfield_query(f, 32, p, 0, c);
    sfield_query(dark, 32, p, 0, open);
    for (i = 0; i < 32; i++) {
        double hidden = 1 - (double)open[16 * i] / sqrt(4 * PI), shines = (double)c[48 * i] + (double)c[48 * i + 16];
        off = fmax(off, fabs(shines / sqrt(4 * PI) - hidden));
        most = fmax(most, hidden);
    }
    print_message("sheets: shining and hidden shares by %.4f, the largest %.3f\n", off, most);
    assert_true(most > 0.15 && off < 0.01);
    sfield_free(f);
    sfield_free(dark);
    free(c);
    free(open);
    free(radiance);
    model_free(&m);
    model_free(&both);
}

static void ambient_comes_from_the_first_coefficient(void **state)
{
    sfield_desc desc;
    sfield_field *f;
    float p[6] = { 2, 0, 0, 0, 0, 100 }, a[2];
    (void)state;
    memset(&desc, 0, sizeof desc);
    f = field_of_sphere(&desc);
    assert_int_equal(sfield_ambient(f, 2, p, a), SFIELD_OK);
    assert_true(fabs((double)a[0] - (1 - 0.06699)) < 0.002 && a[1] > 0.9999f);
    sfield_free(f);
}

/* A light as large as a galaxy or as small as an atom is the same light: all in it is times a power of two. */
static void lights_of_any_size_are_the_same_light(void **state)
{
    static const int powers[5] = { 0, -50, -38, 33, 50 };
    float c[10][3 * 3 * 16];
    int i, k;
    (void)state;
    for (i = 0; i < 10; i++) {
        const float s = (float)ldexp(1, powers[i % 5]);
        const float p[9] = { 0.1f * s, 0, 2 * s, -0.3f * s, s, 2 * s, 2 * s, 3 * s, -0.2f * s };
        sfield_desc desc = small_desc(SFIELD_BASIS_SH);
        sfield_emitter e;
        sfield_field *f;
        memset(&e, 0, sizeof e);
        e.kind = i < 5 ? SFIELD_EMITTER_RECTANGLE : SFIELD_EMITTER_CYLINDER;
        e.u[0] = 0.5f * s;
        e.u[1] = 0.1f * s;
        e.v[1] = 0.7f * s;
        e.radius = 0.2f * s;
        e.radiance[0] = e.radiance[2] = 1;
        assert_int_equal(sfield_build_emitter(&desc, &e, &f, NULL), SFIELD_OK);
        assert_int_equal(sfield_query(f, 3, p, 0, c[i]), SFIELD_OK);
        sfield_free(f);
        for (k = 0; k < 144; k++) assert_true(c[i][k] == c[i - i % 5][k]);
    }
    assert_true(c[0][0] > 0.01f && c[0][0] < 1 && c[5][0] > 0.01f && c[5][0] < 1);
}

/* Of wavelets: what a sphere hides is a cap, wherever on the cube it lies; texels of a corner are 5.2 times smaller
   than those of a middle. And it is the sum over the texels that a query gives. */
static void ambient_of_wavelets_is_the_sum_over_texels(void **state)
{
    enum { SIDE = 32, CELLS = 6 * SIDE * SIDE };
    static float texels[CELLS];
    static const float toward[6][3] = { { 1, 0, 0 }, { 0, -1, 0 }, { 0, 0.70710678f, 0.70710678f },
                                        { -0.57735027f, 0.57735027f, 0.57735027f }, { 0.6f, 0.8f, 0 },
                                        { 0.36f, -0.48f, 0.8f } };
    double most = 0, apart = 0;
    sfield_desc desc;
    sfield_field *f;
    int keep, i, k;
    (void)state;
    for (keep = 0; keep < 2; keep++) {
        memset(&desc, 0, sizeof desc);
        desc.basis = SFIELD_BASIS_HAAR;
        desc.shell_count = 16;
        desc.keep = keep ? 1 : 0;                                     /* all, or the default's hundredth */
        f = field_of_sphere(&desc);
        for (i = 0; i < 18; i++) {
            const double d = i / 6 ? (i / 6 == 1 ? 4 : 9) : 1.7;
            float p[3], open, direction[3];
            double sum = 0;
            for (k = 0; k < 3; k++) p[k] = (float)d * toward[i % 6][k];
            assert_int_equal(sfield_ambient(f, 1, p, &open), SFIELD_OK);
            assert_int_equal(sfield_query(f, 1, p, 0, texels), SFIELD_OK);
            for (k = 0; k < CELLS; k++)
                sum += (double)texels[k] * (double)sfield_cube_texel(SIDE, (uint32_t)k, direction) / (4 * PI);
            apart = fmax(apart, fabs(sum - (double)open));
            most = fmax(most, fabs((1 - (double)open) / blocked(d) - 1));
        }
        sfield_free(f);
    }
    print_message("share hidden in wavelets: off by %.2f %% at most, from its texels by %.1e\n", 100 * most, apart);
    assert_true(most < 0.03 && apart < 2e-6);                         /* shells 30 % apart, a mesh of 64 x 32 */
}

static void flat_lights_have_their_solid_angle(void **state)
{
    sfield_emitter e;
    sfield_desc desc = small_desc(SFIELD_BASIS_SH);
    sfield_field *f;
    float p[9] = { 0, 0, 2, 0, 0, -2, 2, 0, 0.2f }, c[3 * 48];
    double want = 0;
    int i, j;
    (void)state;
    desc.cube_side = 16;
    desc.position_side = 5;
    desc.shell_count = 16;
    memset(&e, 0, sizeof e);
    e.kind = SFIELD_EMITTER_RECTANGLE;
    e.u[0] = e.v[1] = 0.5f;                                           /* one by one, along +z */
    e.radiance[0] = 1;
    assert_int_equal(sfield_build_emitter(&desc, &e, &f, NULL), SFIELD_OK);
    sfield_query(f, 3, p, 0, c);
    print_message("rectangle: %.5f sr of 0.2354\n", (double)c[0] * sqrt(4 * PI));
    assert_true(fabs((double)c[0] * sqrt(4 * PI) - 0.2354) < 0.01);   /* solid angle: 4 atan(1 / (8 sqrt(4.5))) */
    assert_true(fabsf(c[48]) < 0.005f);
    sfield_free(f);
    e.v[0] = 0.3f;                                                    /* its sides at another angle */
    e.v[1] = 0.4f;
    assert_int_equal(sfield_build_emitter(&desc, &e, &f, NULL), SFIELD_OK);
    sfield_query(f, 3, p, 0, c);
    for (i = 0; i < 200; i++)
        for (j = 0; j < 200; j++) {
            double a = (i + 0.5) / 100 - 1, b = (j + 0.5) / 100 - 1, x = 0.5 * a + 0.3 * b, y = 0.4 * b;
            want += 1e-4 * 0.5 * 0.4 * 2 / pow(x * x + y * y + 4, 1.5);
        }
    print_message("parallelogram: %.5f sr of %.5f\n", (double)c[0] * sqrt(4 * PI), want);
    assert_true(fabs((double)c[0] * sqrt(4 * PI) - want) < 0.015);    /* between shells, so high as the rectangle is */
    sfield_free(f);
    e.kind = SFIELD_EMITTER_DISC;
    e.radius = 0.5641896f;                                            /* of the same area */
    e.normal[2] = 1;
    assert_int_equal(sfield_build_emitter(&desc, &e, &f, NULL), SFIELD_OK);
    sfield_query(f, 3, p, 0, c);
    assert_true(fabs((double)c[0] * sqrt(4 * PI) - 2 * PI * (1 - 2 / sqrt(4 + 0.31831))) < 0.01);
    sfield_free(f);
    e.kind = SFIELD_EMITTER_SPHERE;
    e.radius = 0.5f;
    e.cone_half_angle = acosf(0.9f);                                                  /* a lamp: light forwards only */
    assert_int_equal(sfield_build_emitter(&desc, &e, &f, NULL), SFIELD_OK);
    sfield_query(f, 3, p, 0, c);
    assert_true(c[0] > 0.05f && fabsf(c[48]) < 1e-3f && fabsf(c[96]) < 0.01f);
    sfield_free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(views_see_what_rays_see),
        cmocka_unit_test(t72_a_sphere_hides_its_solid_angle),
        cmocka_unit_test(t73_a_sphere_lights_as_in_closed_form),
        cmocka_unit_test(lines_and_cylinders_light_as_in_closed_form),
        cmocka_unit_test(tubes_shine_across_and_keep_to_their_cone),
        cmocka_unit_test(t74_fields_answer_outside_and_inside),
        cmocka_unit_test(t77_coefficients_err_by_half_a_step_of_their_range),
        cmocka_unit_test(t81_more_wavelets_lose_less),
        cmocka_unit_test(a_callback_s_cubes_are_kept_texel_by_texel),
        cmocka_unit_test(only_inside_closed_meshes_positions_move),
        cmocka_unit_test(points_in_another_part_are_moved_out),
        cmocka_unit_test(a_slab_close_by_hides_only_its_own_side),
        cmocka_unit_test(emissive_meshes_shine_outwards_and_by_their_frames),
        cmocka_unit_test(sheets_that_shine_on_both_sides_shine_as_much_as_they_hide),
        cmocka_unit_test(flat_lights_have_their_solid_angle),
        cmocka_unit_test(ambient_comes_from_the_first_coefficient),
        cmocka_unit_test(ambient_of_wavelets_is_the_sum_over_texels),
        cmocka_unit_test(lights_of_any_size_are_the_same_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
