/* rows.h - tests of rows T3 to T14 and T72 to T75 of docs/conformance.md that both sides are put to, in the same
   words: shadowfield.h by algebra_rows_test.c, the GLSL of gl_shadowfield.h by gl_rows_test.c. Include shadowfield.h,
   cmocka.h, conformance.h and util.h before and define ROW_TEST(state), the first line of a test; then define the
   functions row_... below, which take and give bands^2 coefficients a vector, one vector after the other. */
#ifndef SFIELD_ROWS_H
#define SFIELD_ROWS_H

static void row_basis(uint32_t bands, const float *directions, size_t count, float *y);
static void row_cosine(uint32_t bands, const float *directions, size_t count, float *t);
static void row_products(uint32_t bands, const float *a, const float *b, size_t count, float *r);
static void row_rotate(uint32_t bands, const float matrix[16], const float *a, size_t count, float *r);
/* Visibility, 4 bands. */
static void row_query(const sfield_field *field, const float *positions, size_t count, float *v);

static void random_vector(uint64_t *seed, uint32_t n, float *v)
{
    uint32_t k;
    for (k = 0; k < n; k++) v[k] = rnd_in(seed, -1, 1);
}

/* ---- algebra ---- */

static void t3_the_first_band_is_y_z_x(void **state)
{
    ROW_TEST(state)
    static const float axes[18] = { 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1 };
    float y[6 * 4];
    double worst = 0;
    int i;
    row_basis(2, axes, 6, y);
    for (i = 0; i < 6; i++) {
        const float *d = axes + 3 * i;
        worst = fmax(worst, fabs((double)y[4 * i + 1] - 0.4886025 * (double)d[1]) +
                                fabs((double)y[4 * i + 2] - 0.4886025 * (double)d[2]));
        assert_true(fabs((double)y[4 * i + 3] - 0.4886025 * (double)d[0]) < 1e-7);
    }
    CONFORM_MAX("T3", "first band along the axes, off y, z, x", 1e-7, worst);              /* of 7 digits */
}

static void t5_products_have_as_many_coefficients_as_they_should(void **state)
{
    ROW_TEST(state)
    static const unsigned unordered[5] = { 4, 25, 77, 238, 549 }, ordered[5] = { 10, 83, 353, 1158, 2907 };
    static const char *const names[5] = { "unordered coefficients of 2 bands", "of 3 bands", "of 4 bands", "of 5 bands",
                                          "of 6 bands" };
    enum { MOST = 36 * 36 + 1 };
    float *a = (float *)malloc(sizeof(float) * 3 * 36 * MOST), *b = a + 36 * MOST, *c = b + 36 * MOST;
    uint32_t bands, i, j, k;
    uint64_t seed = 5;
    assert_non_null(a);
    for (bands = 2; bands <= 6; bands++) {
        const uint32_t n = bands * bands;
        uint32_t un = 0, all = 0;
        memset(a, 0, sizeof(float) * 2 * 36 * MOST);
        for (i = 0; i < n; i++)
            for (j = 0; j < n; j++) {
                a[n * (i * n + j) + i] = 1;
                b[n * (i * n + j) + j] = 1;
            }
        random_vector(&seed, n, a + n * n * n);                       /* and by 1 */
        b[n * n * n] = 3.5449077f;
        row_products(bands, a, b, n * n + 1, c);
        for (i = 0; i < n; i++)
            for (j = 0; j < n; j++)
                for (k = 0; k < n; k++)
                    if (fabsf(c[n * (i * n + j) + k]) > 1e-6f) {
                        all++;
                        un += i <= j && j <= k;
                    }
        CONFORM("T5", names[bands - 2], unordered[bands - 2], un, 0);
        assert_int_equal(all, ordered[bands - 2]);
        for (k = 0; k < n; k++) assert_true(fabsf(c[n * n * n + k] - a[n * n * n + k]) < 1e-6f);
    }
    free(a);
}

/* V = 1 above the horizon: c_l in closed form. */
static void hemisphere(uint32_t bands, float *v)
{
    memset(v, 0, bands * bands * sizeof *v);
    v[0] = 1.7724539f;
    if (bands > 1) v[2] = 1.5349900f;
    if (bands > 3) v[12] = -0.5861842f;
}

static void t6_squares_lose_light(void **state)
{
    ROW_TEST(state)
    float c[16], v[16];
    hemisphere(4, c);
    row_products(4, c, c, 1, v);
    CONFORM("T6", "percent of 2 pi lost by squaring a hemisphere's step, 4 bands", 7.0,
            100 * (1 - (double)v[0] * 3.5449077 / (2 * PI)), 0.05);
}

/* Three caps that hide half a steradian each, near one another. */
static void random_visibilities(uint64_t *seed, float *v)
{
    float texels[6 * 32 * 32], d[3];
    uint32_t i, k;
    double axis[3];
    for (k = 0; k < 3; k++) {
        rnd_direction(seed, axis);
        axis[2] += 1.5;
        for (i = 0; i < 6 * 32 * 32; i++) {
            double l = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
            sfield_cube_texel(32, i, d);
            texels[i] = ((double)d[0] * axis[0] + (double)d[1] * axis[1] + (double)d[2] * axis[2]) / l < 0.9;
        }
        sfield_sh_project(4, 32, texels, 1, v + 16 * k);
    }
}

static const int orders[6][3] = { { 0, 1, 2 }, { 0, 2, 1 }, { 1, 0, 2 }, { 1, 2, 0 }, { 2, 0, 1 }, { 2, 1, 0 } };

static void t7_triple_products_in_any_order_differ_by_truncation(void **state)
{
    ROW_TEST(state)
    enum { ROUNDS = 8, ALL = 6 * ROUNDS };
    static float v[48], q[3][ALL][16], two[ALL][16], r[ALL][16];
    double triple = 0;
    uint64_t seed = 8;
    int round, o, k;
    for (round = 0; round < ROUNDS; round++) {
        random_visibilities(&seed, v);
        for (o = 0; o < 6; o++)
            for (k = 0; k < 3; k++) memcpy(q[k][6 * round + o], v + 16 * orders[o][k], 64);
    }
    row_products(4, q[0][0], q[1][0], ALL, two[0]);
    row_products(4, two[0], q[2][0], ALL, r[0]);
    for (o = 0; o < ALL; o++)
        for (k = 0; k < 16; k++) triple = fmax(triple, fabs((double)r[o][k] - (double)r[o / 6 * 6][k]));
    CONFORM_MAX("T7", "three occluders in any order, triple products", 0.1, triple);         /* truncation */
    assert_true(triple > 1e-4);
}

static void t9_a_turned_function_has_the_values_of_the_old(void **state)
{
    ROW_TEST(state)
    enum { COUNT = 19 };
    static float x[64 * COUNT], y[64 * COUNT];
    uint64_t seed = 10;
    uint32_t bands, i, k;
    double worst = 0;
    for (bands = 1; bands <= 8; bands++) {
        const uint32_t n = bands * bands;
        float m[16];
        random_vector(&seed, n * COUNT, x);
        matrix_of(m, rnd(&seed) - 0.5, rnd(&seed) - 0.5, rnd(&seed) - 0.5, 6 * rnd(&seed), 2.5, 1, 2, 3);
        row_rotate(bands, m, x, COUNT, y);
        for (i = 0; i < COUNT; i++) {
            double d[3], from[3];
            rnd_direction(&seed, from);
            turn(m, from, d);
            for (k = 0; k < 3; k++) d[k] /= 2.5;
            worst = fmax(worst, fabs(sh_value(bands, y + n * i, d) - sh_value(bands, x + n * i, from)));
        }
    }
    CONFORM_MAX("T9", "rotated vectors of 1 to 8 bands, off the function at 152 directions", 2e-5,
                worst); /* values to 20 */
}

static void t10_a_cosine_has_its_closed_form(void **state)
{
    ROW_TEST(state)
    static const double expected[8] = { 3.141593, 2.094395, 0.785398, 0, -0.130900, 0, 0.049087, 0 };
    float d[33] = { 0, 0, 1 }, t[11 * 64], y[11 * 64];
    double worst = 0, any[3];
    uint64_t seed = 11;
    int i, k;
    for (i = 1; i < 11; i++) {
        rnd_direction(&seed, any);
        for (k = 0; k < 3; k++) d[3 * i + k] = (float)any[k];
    }
    row_cosine(8, d, 11, t);
    row_basis(8, d, 11, y);
    for (k = 0; k < 8; k++) worst = fmax(worst, fabs((double)(t[k * k + k] / y[k * k + k]) - expected[k]));
    CONFORM_MAX("T10", "A_l of 8 bands, off 3.141593, 2.094395, 0.785398, 0, -0.130900, ...", 1e-6,
                worst);                                               /* 6 digits */
    for (i = 0; i < 11; i++)                                          /* uniform light: irradiance pi everywhere */
        assert_true(fabs((double)t[64 * i] * sqrt(4 * PI) - PI) < 1e-6);
}

/* ---- fields ---- */

/* Largest relative error of what a sphere hides at random places from 1.25 r to `far`. */
static double largest_error(const sfield_field *field, double far)
{
    enum { MOST = 300 };
    static float p[3 * MOST], v[16 * MOST];
    double at[MOST], d, dir[3], worst = 0;
    uint64_t seed = 1;
    size_t i, k, count = 0;
    for (d = 1.25; d < far; d *= 1.01, count++) {
        assert_true(count < MOST);
        rnd_direction(&seed, dir);
        at[count] = d;
        for (k = 0; k < 3; k++) p[3 * count + k] = (float)(d * dir[k]);
    }
    row_query(field, p, count, v);
    for (i = 0; i < count; i++)
        worst = fmax(worst, fabs((1 - (double)v[16 * i] / sqrt(4 * PI)) / blocked(at[i]) - 1));
    return worst;
}

static void t72_t74_a_sphere_hides_its_share_between_and_beyond_shells(void **state)
{
    ROW_TEST(state)
    static const float far[3] = { 28.8f, 38.4f, 64 };                 /* 80 r */
    sfield_desc desc;
    sfield_field *field;
    float v[16];
    double off;
    memset(&desc, 0, sizeof desc);
    field = field_of_sphere(&desc);
    CONFORM_MAX("T72", "largest relative error from 1.25 r to 20 r, shadow field", 0.02, largest_error(field, 20));
    row_query(field, far, 1, v);
    CONFORM_MAX("T74", "relative error ten times as far out", 0.02,
                fabs((1 - (double)v[0] / sqrt(4 * PI)) / blocked(80) - 1));
    sfield_free(field);
    desc.spacing = SFIELD_SPACING_UNIFORM;                            /* the paper's: known to be much worse near */
    field = field_of_sphere(&desc);
    off = largest_error(field, 2);
    CONFORM_NOTE("T72", "the same to 2 r with the paper's uniform shells", off);
    assert_true(off > 0.05);
    sfield_free(field);
}

/* Along great circles on the position grid: no step at edges, corners, poles. */
static void t14_t75_a_walk_across_edges_has_no_step(void **state)
{
    ROW_TEST(state)
    enum { CIRCLES = 20, STEPS = 6001 };
    model m = model_soup(12, 0.5, 3);
    sfield_mesh mesh = mesh_of(&m);
    sfield_desc desc;
    sfield_field *field;
    float *p = (float *)malloc(sizeof(float) * 19 * STEPS * CIRCLES), *v = p + 3 * STEPS * CIRCLES;
    double largest = 0, mean = 0;
    size_t i, k, circle;
    uint64_t seed = 2;
    assert_non_null(p);
    memset(&desc, 0, sizeof desc);
    desc.shell_count = 3;
    desc.inner = 1.5f;
    desc.outer = 4;
    assert_int_equal(sfield_build(&desc, &mesh, &field, NULL), SFIELD_OK);
    for (circle = 0; circle < CIRCLES; circle++) {
        double a[3], b[3], dot = 0, l = 0;
        rnd_direction(&seed, a);
        rnd_direction(&seed, b);
        if (circle < 3) {                                             /* through corners and along edges */
            a[0] = a[1] = a[2] = sqrt(1 / 3.0);
            b[0] = 0;
            b[1] = sqrt(0.5);
            b[2] = circle ? -sqrt(0.5) : sqrt(0.5);
        }
        for (k = 0; k < 3; k++) dot += a[k] * b[k];
        for (k = 0; k < 3; k++) b[k] -= dot * a[k];
        for (k = 0; k < 3; k++) l += b[k] * b[k];
        for (k = 0; k < 3; k++) b[k] /= sqrt(l);
        for (i = 0; i < STEPS; i++) {
            double t = 2 * PI * (double)i / (STEPS - 1);
            for (k = 0; k < 3; k++) p[3 * (circle * STEPS + i) + k] = (float)(2.5 * (cos(t) * a[k] + sin(t) * b[k]));
        }
    }
    row_query(field, p, STEPS * CIRCLES, v);
    for (i = 0; i < STEPS * CIRCLES; i++) {
        double step = 0;
        if (i % STEPS == 0) continue;
        for (k = 0; k < 16; k++) step = fmax(step, fabs((double)v[16 * i + k] - (double)v[16 * (i - 1) + k]));
        largest = fmax(largest, step);
        mean += step / ((STEPS - 1) * CIRCLES);
    }
    /* 12: coefficients of the soup change that much faster in some places; a wrong neighbour jumps by hundreds */
    CONFORM_MAX("T14", "largest step by mean step, 20 great circles of 6000 steps", 12, largest / mean);
    CONFORM_MAX("T75", "largest step by mean step, 20 great circles of 6000 steps", 12, largest / mean);
    sfield_free(field);
    free(p);
    model_free(&m);
}

#define SFIELD_ROWS(test)                                                                                       \
    test(t3_the_first_band_is_y_z_x), test(t5_products_have_as_many_coefficients_as_they_should),               \
    test(t6_squares_lose_light), test(t7_triple_products_in_any_order_differ_by_truncation),                    \
    test(t9_a_turned_function_has_the_values_of_the_old), test(t10_a_cosine_has_its_closed_form),               \
    test(t72_t74_a_sphere_hides_its_share_between_and_beyond_shells), test(t14_t75_a_walk_across_edges_has_no_step)

#endif
