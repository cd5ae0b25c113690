/* algebra_rows_test - spherical harmonics and Haar wavelets of shadowfield.h against closed forms: the rows of
   shadowfield/rows.h, and T1 to T8, T13 and T81 of docs/conformance.md as far as only the CPU computes them. */
#define SFIELD_STATIC
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include "conformance.h"

#define ROW_TEST(state) (void)(state);
#include "rows.h"

static sfield_algebra *algebra_of(uint32_t bands)
{
    sfield_algebra *t = NULL;
    assert_int_equal(sfield_algebra_create(bands, NULL, &t), SFIELD_OK);
    return t;
}

/* ---- the rows by shadowfield.h ---- */

static void row_basis(uint32_t bands, const float *directions, size_t count, float *y)
{
    double d[3], out[64];
    size_t i, k;
    for (i = 0; i < count; i++) {
        for (k = 0; k < 3; k++) d[k] = (double)directions[3 * i + k];
        sfield_sh_basis(bands, d, out);
        for (k = 0; k < bands * bands; k++) y[bands * bands * i + k] = (float)out[k];
    }
}

static void row_cosine(uint32_t bands, const float *directions, size_t count, float *t)
{
    float factors[8];
    size_t i, k, l;
    sfield_sh_cosine(bands, factors);
    row_basis(bands, directions, count, t);
    for (i = 0; i < count; i++)
        for (l = 0, k = 0; l < bands; l++)
            for (; k < (l + 1) * (l + 1); k++) t[bands * bands * i + k] *= factors[l];
}

static void row_products(uint32_t bands, const float *a, const float *b, size_t count, float *r)
{
    sfield_algebra *t = algebra_of(bands);
    const size_t n = bands * bands;
    size_t i;
    for (i = 0; i < count; i++) sfield_sh_product(t, 1, a + n * i, b + n * i, r + n * i, 1);
    sfield_algebra_free(t);
}

static void row_rotate(uint32_t bands, const float matrix[16], const float *a, size_t count, float *r)
{
    sfield_algebra *t = algebra_of(bands);
    const size_t n = bands * bands;
    sfield_rotation turned;
    size_t i;
    assert_int_equal(sfield_sh_rotation(t, matrix, &turned), SFIELD_OK);
    assert_false(turned.identity);
    for (i = 0; i < count; i++) assert_int_equal(sfield_sh_rotate(&turned, 1, a + n * i, r + n * i, 1), SFIELD_OK);
    sfield_algebra_free(t);
}

static void row_query(const sfield_field *field, const float *positions, size_t count, float *v)
{
    assert_int_equal(sfield_query(field, count, positions, 0, v), SFIELD_OK);
}

/* ---- what only the CPU computes ---- */

static void t1_gram_matrix_is_the_identity(void **state)
{
    static double node[4 * 256];
    double gram[64][64] = { { 0 } }, y[64], worst = 0;
    uint32_t i, j;
    size_t g;
    (void)state;
    sfield__fill_grid(14, node);
    for (g = 0; g < sfield__grid_size(14); g++) {
        sfield_sh_basis(8, node + 4 * g, y);
        for (i = 0; i < 64; i++)
            for (j = 0; j < 64; j++) gram[i][j] += node[4 * g + 3] * y[i] * y[j];
    }
    for (i = 0; i < 64; i++)
        for (j = 0; j < 64; j++) worst = fmax(worst, fabs(gram[i][j] - (i == j)));
    CONFORM_MAX("T1", "Gram matrix of 8 bands, off the identity", 1e-12, worst);          /* doubles */
}

static void t2_a_constant_has_one_coefficient(void **state)
{
    float texels[6 * 16 * 16], c[64], dot;
    uint32_t k;
    (void)state;
    for (k = 0; k < 6 * 16 * 16; k++) texels[k] = 1;
    assert_int_equal(sfield_sh_project(8, 16, texels, 1, c), SFIELD_OK);
    CONFORM("T2", "c00 of the constant 1", 3.5449077, c[0], 1e-6);                         /* a float */
    for (k = 1; k < 64; k++) assert_true(fabsf(c[k]) < 1e-5f);
    assert_int_equal(sfield_sh_dot(4, 1, c, c, &dot, 1), SFIELD_OK);
    CONFORM("T2", "integral of its square", 12.5663706, dot, 1e-5);
}

static void t3_harmonics_have_the_known_order_and_signs(void **state)
{
    static const double axes[6][3] = {
        { 1, 0, 0 }, { -1, 0, 0 }, { 0, 1, 0 }, { 0, -1, 0 }, { 0, 0, 1 }, { 0, 0, -1 }
    };
    float texels[3][6 * 16 * 16], c[64], d[3];
    double y[64];
    uint32_t i, k;
    (void)state;
    for (i = 0; i < 6 * 16 * 16; i++) {
        sfield_cube_texel(16, i, d);
        for (k = 0; k < 3; k++) texels[k][i] = d[k];
    }
    for (k = 0; k < 3; k++) {
        sfield_sh_project(4, 16, texels[k], 1, c);
        for (i = 0; i < 6; i++) assert_true(fabs(sh_value(4, c, axes[i]) - axes[i][k]) < 3e-3); /* of a step function */
    }
    for (i = 0; i < 6; i++) {
        sfield_sh_basis(2, axes[i], y);
        assert_true(fabs(y[1] - 0.4886025 * axes[i][1]) < 1e-7);
        assert_true(fabs(y[2] - 0.4886025 * axes[i][2]) < 1e-7);
        assert_true(fabs(y[3] - 0.4886025 * axes[i][0]) < 1e-7);
    }
}

static void t4_four_bands_are_16_coefficients(void **state)
{
    double y[65], d[3] = { 0.6, 0, 0.8 };
    int k;
    (void)state;
    for (k = 0; k < 65; k++) y[k] = -77;
    sfield_sh_basis(4, d, y);
    assert_true(y[15] != -77 && y[16] == -77);
    for (k = 0; k < 65 && y[k] != -77; k++) { }
    CONFORM("T4", "coefficients of 4 bands", 16, k, 0);
}

/* The table and every kernel against quadrature in double, all bands, whole tiles and rests. */
static void products_of_many_vectors_are_the_quadratures(void **state)
{
    uint32_t bands, i, k, simd;
    uint64_t seed = 6;
    (void)state;
    for (bands = 1; bands <= 8; bands++) {
        sfield_algebra *t = algebra_of(bands);
        uint32_t n = bands * bands, count = 37;
        float *a = (float *)malloc(4 * 3 * 64 * 37), *b = a + 64 * 37, *c = b + 64 * 37, two[128];
        double exact[64], worst = 0;
        random_vector(&seed, 64 * 37, a);
        random_vector(&seed, 64 * 37, b);
        for (simd = 0; simd <= (uint32_t)sfield__simd_level(); simd++) {
            t->simd = (int)simd;
            sfield_sh_product(t, count, a, b, c, count);
            for (i = 0; i < count; i += 9) {
                for (k = 0; k < n; k++) {
                    two[k] = a[k * count + i];
                    two[n + k] = b[k * count + i];
                }
                assert_int_equal(sfield_sh_product_n(bands, 2, two, NULL, exact), SFIELD_OK);
                for (k = 0; k < n; k++) worst = fmax(worst, fabs((double)c[k * count + i] - exact[k]));
            }
            assert_true(worst < 1e-6 * n);
        }
        sfield_sh_product(t, count, a, b, a, count);                 /* in place */
        for (k = 0; k < n * count; k++) assert_true(fabsf(a[k] - c[k]) < 1e-5f);
        free(a);
        sfield_algebra_free(t);
    }
}

/* What is written out for 4 bands against loops over the tables: equal bits, so equal pictures on every processor. */
static void four_bands_have_the_bits_of_the_loops(void **state)
{
#if SFIELD__SIMD_SETS
    enum { N = 16 * SFIELD__LANES };
    typedef void (*product)(const sfield_algebra *, const float *, const float *, float *, size_t, int);
    typedef void (*rotate)(const sfield_rotation *, const float *, float *, size_t, int);
    static const product products[2][2] = { { sfield__product_avx2, sfield__product4_avx2 },
                                            { sfield__product_avx512, sfield__product4_avx512 } };
    static const rotate rotations[2][2] = { { sfield__rotate_avx2, sfield__rotate4_avx2 },
                                            { sfield__rotate_avx512, sfield__rotate4_avx512 } };
    static const float turn[16] = { 0.36f, 0.48f, -0.8f, 0, -0.8f, 0.6f, 0, 0, 0.48f, 0.64f, 0.6f, 0, 0, 0, 0, 1 };
    float a[N], b[N], loops[N], straight[N];
    sfield_algebra *t = algebra_of(4);
    sfield_rotation r;
    uint64_t seed = 44;
    int simd, way;
    (void)state;
    assert_int_equal(sfield_sh_rotation(t, turn, &r), SFIELD_OK);
    random_vector(&seed, N, a);
    random_vector(&seed, N, b);
    for (simd = 0; simd < sfield__simd_level(); simd++)
        for (way = 0; way < 2; way++) {
            products[simd][0](t, a, b, loops, SFIELD__LANES, way);
            memcpy(straight, a, sizeof a);
            products[simd][1](t, straight, b, straight, SFIELD__LANES, way);        /* in place */
            assert_memory_equal(straight, loops, sizeof loops);
            rotations[simd][0](&r, a, loops, SFIELD__LANES, way);
            memcpy(straight, a, sizeof a);
            rotations[simd][1](&r, straight, straight, SFIELD__LANES, way);
            assert_memory_equal(straight, loops, sizeof loops);
        }
    sfield_algebra_free(t);
#else
    (void)state;            /* no intrinsics: the loops alone */
#endif
}

static void t6_products_are_integrals_cut_to_the_bands(void **state)
{
    sfield_algebra *t = algebra_of(4);
    float texels[6 * 64 * 64], v[16], c[16], d[3], many[3 * 16];
    double out[16], sum = 0, exact = 0, node[4 * 1024];
    uint32_t i, k;
    uint64_t seed = 7;
    size_t g;
    (void)state;
    for (i = 0; i < 6 * 64 * 64; i++) {
        sfield_cube_texel(64, i, d);
        texels[i] = d[2] > 0;
    }
    sfield_sh_project(4, 64, texels, 1, v);
    hemisphere(4, c);
    for (k = 0; k < 16; k++) assert_true(fabsf(v[k] - c[k]) < 1e-4f);
    for (k = 0; k < 16; k++) sum += (double)c[k] * (double)c[k];
    assert_true(fabs(sum - 5.8414) < 1e-4);
    sfield_sh_product(t, 1, c, c, v, 1);
    assert_true(fabs((double)v[0] * 3.5449077 - sum) < 1e-5);
    random_vector(&seed, 48, many);
    assert_int_equal(sfield_sh_product_n(4, 3, many, NULL, out), SFIELD_OK);
    sfield__fill_grid(20, node);                                           /* a finer grid: the same integral */
    for (g = 0; g < sfield__grid_size(20); g++)
        exact += node[4 * g + 3] * sh_value(4, many, node + 4 * g) * sh_value(4, many + 16, node + 4 * g) *
                 sh_value(4, many + 32, node + 4 * g);
    CONFORM_MAX("T6", "n-product of three, off the integral on a finer grid", 1e-9,
                fabs(out[0] * sqrt(4 * PI) - exact));
    sfield_algebra_free(t);
}

static void t7_occluders_may_come_in_any_order(void **state)
{
    sfield_algebra *t = algebra_of(4);
    double exact = 0, logs = 0;
    uint64_t seed = 8;
    int round, o, k;
    (void)state;
    for (round = 0; round < 8; round++) {
        float v[48], l[48], e[6][16], x[16];
        double n[6][16];
        random_visibilities(&seed, v);
        for (k = 0; k < 3; k++) assert_int_equal(sfield_sh_log(t, v + 16 * k, l + 16 * k), SFIELD_OK);
        for (o = 0; o < 6; o++) {
            float three[48];
            const int *q = orders[o];
            for (k = 0; k < 3; k++) memcpy(three + 16 * k, v + 16 * q[k], 64);
            sfield_sh_product_n(4, 3, three, NULL, n[o]);
            for (k = 0; k < 16; k++) x[k] = l[16 * q[0] + k] + l[16 * q[1] + k] + l[16 * q[2] + k];
            sfield_sh_exp(t, 1, x, e[o], 1);
            for (k = 0; k < 16; k++) {
                exact = fmax(exact, fabs(n[o][k] - n[0][k]));
                logs = fmax(logs, fabs((double)e[o][k] - (double)e[0][k]));
            }
        }
    }
    CONFORM_MAX("T7", "three occluders in any order, n-product", 1e-12, exact);              /* doubles */
    CONFORM_MAX("T7", "three occluders in any order, exp of logs", 2e-5, logs);              /* floats */
    sfield_algebra_free(t);
}

static void an_exponential_undoes_a_logarithm(void **state)
{
    sfield_algebra *t = algebra_of(4);
    float v[48], l[16], e[16], one[16] = { 3.5449077f };
    uint64_t seed = 9;
    int k;
    (void)state;
    sfield_sh_log(t, one, l);
    for (k = 0; k < 16; k++) assert_true(fabsf(l[k]) < 1e-6f);
    random_visibilities(&seed, v);                                    /* eigenvalues above 0.02: exp undoes log */
    sfield_sh_log(t, v, l);
    sfield_sh_exp(t, 1, l, e, 1);
    for (k = 0; k < 16; k++) assert_true(fabsf(e[k] - v[k]) < 0.02f);
    memset(l, 0, sizeof l);
    l[0] = -3.5449077f;                                               /* exp of the constant -1 */
    sfield_sh_exp(t, 1, l, e, 1);
    assert_true(fabs((double)e[0] - 3.5449077 * exp(-1)) < 1e-5 && fabsf(e[5]) < 1e-6f);
    sfield_algebra_free(t);
}

static void extremes(uint32_t bands, const float *c, double *low, double *high)
{
    int i;
    *low = 1e9;
    *high = -1e9;
    for (i = 0; i <= 20000; i++) {
        double z = -1 + i / 10000.0, d[3], v;
        d[0] = sqrt(1 - z * z);
        d[1] = 0;
        d[2] = z;
        v = sh_value(bands, c, d);
        *low = fmin(*low, v);
        *high = fmax(*high, v);
    }
}

static void t8_a_window_takes_ringing_away(void **state)
{
    float v[16], factors[8], strength;
    double low, high;
    uint32_t k, l;
    (void)state;
    hemisphere(4, v);
    extremes(4, v, &low, &high);
    assert_true(fabs(low + 0.1137) < 1e-4 && fabs(high - 1.1137) < 1e-4);
    extremes(3, v, &low, &high);
    assert_true(fabs(low + 0.25) < 1e-6 && fabs(high - 1.25) < 1e-6);
    strength = sfield_sh_window_fit(4, v, 0);
    sfield_sh_window(4, strength, factors);
    for (l = 0, k = 0; l < 4; l++)
        for (; k < (l + 1) * (l + 1); k++) v[k] *= factors[l];
    extremes(4, v, &low, &high);
    CONFORM_MIN("T8", "least value of a windowed step of 4 bands", -1e-3, low); /* checked at 2,592 directions */
    assert_true(low < 0.02 && strength > 0);
    hemisphere(2, v);
    v[2] = 0.1f;
    assert_true(sfield_sh_window_fit(2, v, 0) == 0);                  /* nothing to do */
}

/* Energy of each band, the inverse, every kernel. */
static void rotations_there_and_back_change_nothing(void **state)
{
    uint64_t seed = 10;
    uint32_t bands, k, l, i, simd;
    (void)state;
    for (bands = 1; bands <= 8; bands++) {
        sfield_algebra *t = algebra_of(bands);
        uint32_t n = bands * bands, count = 19;
        float a[64 * 19], b[64 * 19], c[64 * 19], m[16], back[16];
        sfield_rotation r, inverse;
        random_vector(&seed, n * count, a);
        matrix_of(m, rnd(&seed) - 0.5, rnd(&seed) - 0.5, rnd(&seed) - 0.5, 6 * rnd(&seed), 2.5, 1, 2, 3);
        assert_int_equal(sfield_sh_rotation(t, m, &r), SFIELD_OK);
        assert_false(r.identity);
        assert_int_equal(sfield_sh_rotate(&r, count, a, b, count), SFIELD_OK);
        for (i = 0; i < count; i++) {
            for (l = 0, k = 0; l < bands; l++) {
                double before = 0, after = 0;
                for (; k < (l + 1) * (l + 1); k++) {
                    before += (double)a[k * count + i] * (double)a[k * count + i];
                    after += (double)b[k * count + i] * (double)b[k * count + i];
                }
                assert_true(fabs(before - after) < 1e-5);
            }
        }
        for (k = 0; k < 16; k++) back[k] = k < 11 && k % 4 < 3 ? m[4 * (k % 4) + k / 4] : k == 15;
        assert_int_equal(sfield_sh_rotation(t, back, &inverse), SFIELD_OK);
        sfield_sh_rotate(&inverse, count, b, c, count);
        for (k = 0; k < n * count; k++) assert_true(fabsf(c[k] - a[k]) < 2e-6f);
        for (simd = 0; simd <= (uint32_t)sfield__simd_level(); simd++) {    /* every kernel, and the transposed way */
            sfield__rotate16(&r, a, c, count, 0, (int)simd);
            for (k = 0; k < n; k++) assert_true(fabsf(c[k * count] - b[k * count]) < 1e-5f);
            sfield__rotate16(&r, b, c, count, 1, (int)simd);
            for (k = 0; k < n; k++) assert_true(fabsf(c[k * count] - a[k * count]) < 1e-5f);
        }
        sfield_algebra_free(t);
    }
}

static void t9_a_quarter_turn_brings_x_to_y(void **state)
{
    sfield_algebra *t = algebra_of(2);
    float m[16], x[4] = { 0, 0, 0, 1 }, y[4];
    sfield_rotation r;
    (void)state;
    matrix_of(m, 0, 0, 1, PI / 2, 1, 0, 0, 0);
    sfield_sh_rotation(t, m, &r);
    sfield_sh_rotate(&r, 1, x, y, 1);
    assert_true(fabsf(y[1] - 1) < 1e-6f && fabsf(y[3]) < 1e-6f);       /* x, number 3, becomes y, number 1 */
    matrix_of(m, 0, 0, 1, 0, 3, 0, 0, 0);
    sfield_sh_rotation(t, m, &r);
    assert_true(r.identity);
    sfield_algebra_free(t);
}

static void t13_texels_of_a_cube_fill_the_sphere(void **state)
{
    static const uint32_t sides[4] = { 4, 16, 32, 64 };
    float d[3], corner, middle;
    double worst = 0;
    uint32_t i, k;
    (void)state;
    for (k = 0; k < 4; k++) {
        uint32_t n = sides[k] * sides[k];
        double face = 0, all = 0;
        for (i = 0; i < 6 * n; i++) {
            double a = (double)sfield_cube_texel(sides[k], i, d);
            all += a;
            face += i < n ? a : 0;
            assert_int_equal(sfield_cube_find(sides[k], d), i);
        }
        assert_true(fabs(face - 2.094395) < 1e-6);
        worst = fmax(worst, fabs(all - 4 * PI));
    }
    CONFORM_MAX("T13", "solid angle of cubes of side 4 to 64, off 4 pi", 1e-5, worst);       /* sums of 24,576 floats */
    corner = sfield_cube_texel(64, 0, d);                             /* 0.19245 in the limit; here texel centres */
    middle = sfield_cube_texel(64, sfield__texel_number(64, 0, 32, 32), d);
    assert_true(fabs((double)(corner / middle) - pow((1 + 2 * pow(63 / 64.0, 2)) / (1 + 2 / 4096.0), -1.5)) < 5e-4);
    assert_true(fabs(pow(3, -1.5) - 0.19245) < 1e-5);
}

static void t81_products_of_wavelets_are_those_of_texels(void **state)
{
    uint32_t side, i, k;
    uint64_t seed = 12;
    (void)state;
    for (side = 4; side <= 64; side *= 2) {
        uint32_t n = 6 * side * side;
        float *a = (float *)malloc(5 * 4 * (size_t)n), *b = a + n, *c = b + n, *x = c + n, *y = x + n;
        double before = 0, after = 0, worst = 0;
        random_vector(&seed, 2 * n, a);
        assert_int_equal(sfield_haar_forward(side, a, x), SFIELD_OK);
        assert_int_equal(sfield_haar_forward(side, b, y), SFIELD_OK);
        for (i = 0; i < n; i++) {
            before += (double)a[i] * (double)a[i];
            after += (double)x[i] * (double)x[i];
        }
        assert_true(fabs(before - after) < 1e-6 * before);            /* Parseval */
        sfield_haar_inverse(side, x, c);
        for (i = 0; i < n; i++) assert_true(fabsf(c[i] - a[i]) < 1e-5f);
        for (k = 0; k < 2; k++) {                                     /* all coefficients, then few of one */
            for (i = 0; i < n && k; i++) y[i] = i % 7 == 0 && fabsf(y[i]) > 1 ? y[i] : 0;
            if (k) sfield_haar_inverse(side, y, b);
            assert_int_equal(sfield_haar_product(side, x, y, c), SFIELD_OK);
            for (i = 0; i < n && !k; i++) a[i] *= b[i];
            if (k) {
                sfield_haar_inverse(side, x, a);
                for (i = 0; i < n; i++) a[i] *= b[i];
            }
            sfield_haar_inverse(side, c, x);
            for (i = 0; i < n; i++) worst = fmax(worst, fabs((double)x[i] - (double)a[i]));
            sfield_haar_forward(side, a, x);
        }
        if (side == 32) CONFORM_MAX("T81", "product of Haar coefficients, off that of texels, 32 x 32", 1e-4, worst);
        assert_true(worst < 1e-4);                                    /* floats */
        free(a);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        SFIELD_ROWS(cmocka_unit_test),
        cmocka_unit_test(t1_gram_matrix_is_the_identity),
        cmocka_unit_test(t2_a_constant_has_one_coefficient),
        cmocka_unit_test(t3_harmonics_have_the_known_order_and_signs),
        cmocka_unit_test(t4_four_bands_are_16_coefficients),
        cmocka_unit_test(products_of_many_vectors_are_the_quadratures),
        cmocka_unit_test(four_bands_have_the_bits_of_the_loops),
        cmocka_unit_test(t6_products_are_integrals_cut_to_the_bands),
        cmocka_unit_test(t7_occluders_may_come_in_any_order),
        cmocka_unit_test(an_exponential_undoes_a_logarithm),
        cmocka_unit_test(t8_a_window_takes_ringing_away),
        cmocka_unit_test(rotations_there_and_back_change_nothing),
        cmocka_unit_test(t9_a_quarter_turn_brings_x_to_y),
        cmocka_unit_test(t13_texels_of_a_cube_fill_the_sphere),
        cmocka_unit_test(t81_products_of_wavelets_are_those_of_texels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
