/* units_test - the units of src/shared with their placeholder prefix, against closed forms and brute force. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <math.h>
#include <cmocka.h>

#include "src/shared/fp_begin.h"
#include "src/shared/mem.h"
#include "src/shared/v3.h"
#include "src/shared/unit.h"
#include "src/shared/m4.h"
#include "src/shared/trig.h"
#include "src/shared/bytes.h"
#include "src/shared/crc.h"
#include "src/shared/rng.h"
#include "src/shared/lds.h"
#include "src/shared/hilbert.h"
#include "src/shared/octa.h"
#include "src/shared/cdf.h"
#include "src/shared/cpu.h"
#include "src/shared/bits.h"
#include "src/shared/part.h"
#include "src/shared/batch.h"
#include "src/shared/raster.h"
#include "src/shared/mask.h"
#include "src/shared/fp_end.h"

#define PI 3.14159265358979323846
#define LARGEST_BELOW_1 0.99999994f

/* cmocka's assert_float_equal compares in float. */
#define assert_near(a, b, e) near((double)(a), (double)(b), (double)(e), __LINE__)

static void near(double a, double b, double epsilon, int line)
{
    if (!(fabs(a - b) <= epsilon)) fail_msg("line %d: %.9g is not within %.3g of %.9g", line, a, epsilon, b);
}

static double larger(double a, double b) { return a > b ? a : b; }

/* |a - b| in units of the last place of b as a float. */
static double ulps(float a, double b)
{
    float f = fabsf((float)b);
    double place = (double)P_from_bits(P_to_bits(f) + 1u) - (double)f;
    return fabs((double)a - b) / place;
}

static float uniform(uint32_t stream, uint32_t i, double lo, double hi)
{
    return (float)(lo + (hi - lo) * (double)P_random(1, stream, i));
}

/* ---- mem ---- */

static int live;

static void *counting_alloc(size_t size, void *user)
{
    live++;
    (void)user;
    return malloc(size);
}

static void counting_free(void *memory, void *user)
{
    live--;
    (void)user;
    free(memory);
}

static void sizes_that_overflow_are_refused(void **state)
{
    size_t out = 7;
    P_allocator a = P_allocator_make(counting_alloc, counting_free, NULL);
    void *p, *q;

    (void)state;
    assert_true(P_mul_size(3, 5, &out) && out == 15);
    assert_true(P_mul_size(0, SIZE_MAX, &out) && out == 0);
    assert_true(P_mul_size(SIZE_MAX, 1, &out) && out == SIZE_MAX);
    assert_false(P_mul_size(SIZE_MAX / 2 + 1, 2, &out));
    assert_true(out == SIZE_MAX);
    assert_true(P_add_size(SIZE_MAX - 1, 1, &out) && out == SIZE_MAX);
    assert_false(P_add_size(SIZE_MAX, 1, &out));

    p = P_alloc(&a, 10);
    q = P_alloc_array(&a, 3, 4);
    assert_non_null(p);
    assert_non_null(q);
    assert_int_equal(live, 2);
    assert_null(P_alloc(&a, 0));
    assert_null(P_alloc_array(&a, SIZE_MAX / 2, 3));
    assert_int_equal(live, 2);
    P_free(&a, q);
    P_free(&a, p);
    P_free(&a, NULL);
    assert_int_equal(live, 0);

    assert_true(P_allocator_valid(NULL, NULL) && P_allocator_valid(counting_alloc, counting_free));
    assert_false(P_allocator_valid(counting_alloc, NULL));
    a = P_allocator_make(NULL, NULL, NULL);
    p = P_alloc(&a, 10);
    assert_non_null(p);
    P_free(&a, p);
}

/* ---- v3, m4 ---- */

static void tiny_and_huge_vectors_normalise(void **state)
{
    static const float sizes[] = { 1e-44f, 1e-38f, 1e-20f, 1.0f, 1e20f, 3e38f };
    size_t i;

    (void)state;
    for (i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        P_v3 n = P_v3_normalize(P_v3_make(-sizes[i], sizes[i], sizes[i]));
        assert_near(P_v3_length(n), 1.0f, 2e-7f);
        assert_near(n.x, -0.57735027f, 1e-6f);
    }
    assert_true(P_v3_length(P_v3_normalize(P_v3_make(0, 0, 0))) == 0.0f);
}

static void infinities_and_nans_are_not_finite(void **state)
{
    (void)state;
    assert_true(P_finite(0.0f) && P_finite(-3e38f) && P_finite(1e-45f));
    assert_false(P_finite(P_from_bits(0x7f800000u)));
    assert_false(P_finite(P_from_bits(0xff800000u)));
    assert_false(P_finite(P_from_bits(0x7fc00000u)));
    assert_false(P_v3_finite(P_v3_make(1, 2, P_from_bits(0xffc00001u))));
}

static void lengths_of_0_97_to_1_03_count_as_unit(void **state)
{
    const float nan = P_from_bits(0x7fc00000u), infinite = P_from_bits(0x7f800000u);
    (void)state;
    assert_true(P_is_unit2(1) && P_is_unit2(0.97001f * 0.97001f) && P_is_unit2(1.02999f * 1.02999f));
    assert_false(P_is_unit2(0.96999f * 0.96999f) || P_is_unit2(1.03001f * 1.03001f));
    assert_false(P_is_unit2(0) || P_is_unit2(nan) || P_is_unit2(infinite));
}

static void a_basis_is_orthonormal_and_right_handed(void **state)
{
    uint32_t i;
    (void)state;
    for (i = 0; i < 10008; i++) {
        P_v3 n, b, c;
        if (i < 8) n = P_v3_make(0, i & 1 ? 1e-20f : 0.0f, (i & 2 ? -1.0f : 1.0f) * (i & 4 ? 0.0f : 1.0f));
        else n = P_octa_direction(P_random(1, 2, i), P_random(1, 3, i));
        if (i < 8 && i & 4) n = P_v3_make(1, 0, n.z);
        P_v3_basis(n, &b, &c);
        assert_near(P_v3_length(b), 1, 2e-6f);
        assert_near(P_v3_length(c), 1, 2e-6f);
        assert_near(P_v3_dot(b, c), 0, 2e-6f);
        assert_near(P_v3_length(P_v3_sub(P_v3_cross(b, c), n)), 0, 3e-6f);
    }
}

static void vectors_add_scale_and_multiply(void **state)
{
    P_v3 a = P_v3_make(1, 2, 3), b = P_v3_make(-4, 5, 0.5f), c;
    float f[3];
    (void)state;
    assert_near(P_v3_dot(a, b), 7.5f, 0);
    assert_near(P_v3_dot(P_v3_cross(a, b), a), 0, 1e-6f);
    c = P_v3_madd(a, b, 2);
    assert_true(c.x == -7.0f && c.y == 12.0f && c.z == 4.0f);
    c = P_v3_min(a, b);
    assert_true(c.x == -4.0f && c.y == 2.0f && c.z == 0.5f);
    c = P_v3_max(a, b);
    assert_true(c.x == 1.0f && c.y == 5.0f && c.z == 3.0f);
    P_v3_store(f, P_v3_mul(a, b));
    c = P_v3_load(f);
    assert_true(c.x == -4.0f && c.y == 10.0f && c.z == 1.5f);
}

/* Rotation about a random axis times s, and a translation. */
static void rotation(float *m, uint32_t seed, float s)
{
    P_v3 n = P_octa_direction(P_random(seed, 0, 0), P_random(seed, 0, 1)), b, c;
    P_v3_basis(n, &b, &c);
    P_v3_store(m, P_v3_scale(b, s));
    P_v3_store(m + 4, P_v3_scale(c, s));
    P_v3_store(m + 8, P_v3_scale(n, s));
    P_v3_store(m + 12, P_v3_make(3, -7, 11));
    m[3] = m[7] = m[11] = 0.0f;
    m[15] = 1.0f;
}

static void an_inverse_undoes_its_matrix_or_fails(void **state)
{
    uint32_t i;
    float m[16], inverse[16];
    (void)state;
    for (i = 0; i < 1000; i++) {
        P_v3 p = P_v3_make(1, 2, 3), q;
        rotation(m, i, i & 1 ? 1e-4f : 50.0f);
        if (i & 2) m[4] *= 3.0f;
        assert_true(P_m4_affine_inverse(inverse, m));
        q = P_m4_point(inverse, P_m4_point(m, p));
        assert_near(P_v3_length(P_v3_sub(p, q)), 0, (i & 1) ? 0.2f : 1e-5f);
        q = P_m4_direction(inverse, P_m4_direction(m, p));
        assert_near(P_v3_length(P_v3_sub(p, q)), 0, 1e-4f);
        memcpy(inverse, m, sizeof m);
        assert_true(P_m4_affine_inverse(inverse, inverse));
    }
    m[8] = m[4], m[9] = m[5], m[10] = m[6];
    inverse[0] = 5.0f;
    assert_false(P_m4_affine_inverse(inverse, m));
    m[0] = P_from_bits(0x7fc00000u);
    assert_false(P_m4_affine_inverse(inverse, m));
    memset(m, 0, sizeof m);
    assert_false(P_m4_affine_inverse(inverse, m));
}

static void sixteen_zeros_stand_for_the_identity(void **state)
{
    float m[16] = { 0 };
    const float *identity = P_m4_or_identity(m);
    int i;
    (void)state;
    for (i = 0; i < 16; i++) assert_true(identity[i] == (i % 5 == 0 ? 1.0f : 0.0f));
    m[3] = -0.0f;
    assert_ptr_equal(P_m4_or_identity(m), identity);
    for (i = 0; i < 16; i++) {                              /* one number is enough to be a matrix, if a bad one */
        memset(m, 0, sizeof m);
        m[i] = i & 1 ? 1e-30f : P_from_bits(0x7fc00000u);
        assert_ptr_equal(P_m4_or_identity(m), m);
    }
}

static void rotations_times_a_scale_are_told_apart(void **state)
{
    uint32_t i;
    float m[16], scale = 0.0f;
    (void)state;
    for (i = 0; i < 100; i++) {
        float s = i & 1 ? 0.001f : 70.0f;
        rotation(m, i, s);
        assert_true(P_m4_is_rigid_uniform(m, &scale));
        assert_near(scale, s, 1e-5f * s);
        m[5] += 0.01f * s;
        m[0] -= 0.01f * s;
        assert_false(P_m4_is_rigid_uniform(m, &scale));
        rotation(m, i, s);
        m[0] = -m[0], m[1] = -m[1], m[2] = -m[2];           /* mirrored */
        assert_false(P_m4_is_rigid_uniform(m, &scale));
        rotation(m, i, s);
        m[15] = 2.0f;
        assert_false(P_m4_is_rigid_uniform(m, &scale));
        rotation(m, i, 0.0f);
        assert_false(P_m4_is_rigid_uniform(m, &scale));
    }
}

/* ---- trig: the bounds that its head comment states ---- */

static void sin_and_cos_keep_their_bounds(void **state)
{
    uint32_t i;
    double error = 0, ulp = 0;
    (void)state;
    for (i = 0; i < 1000000; i++) {
        float x = uniform(2, i, i & 1 ? -8192 : -8, i & 1 ? 8192 : 8), s, c;
        P_sincos(x, &s, &c);
        error = larger(error, fabs((double)s - sin((double)x)));
        error = larger(error, fabs((double)c - cos((double)x)));
        if (fabsf(x) < 1.5f) ulp = larger(ulp, ulps(s, sin((double)x)));
    }
    print_message("sin, cos: %.3g absolute, sin %.2f ulp below 1.5\n", error, ulp);
    assert_true(error < 1e-7 && ulp < 1.5);
    assert_true(P_sin(0.0f) == 0.0f && P_cos(0.0f) == 1.0f && P_sin(1e-30f) == 1e-30f);
    assert_true(P_finite(P_sin(P_from_bits(0x7fc00000u))) && P_finite(P_cos(3e38f)));
}

static void asin_acos_and_atan2_keep_their_bounds(void **state)
{
    uint32_t i;
    double acos_error = 0, acos_ulp = 0, asin_error = 0, atan_error = 0, atan_ulp = 0;
    (void)state;
    for (i = 0; i < 1000000; i++) {
        float x = uniform(3, i, -1, 1), y = uniform(4, i, -1, 1);
        if (i % 3 == 0) x = (x < 0 ? -1.0f : 1.0f) * (1.0f - x * x * x * x);
        if (i % 5 == 0) y *= y * y * y;
        acos_error = larger(acos_error, fabs((double)P_acos(x) - acos((double)x)));
        acos_ulp = larger(acos_ulp, ulps(P_acos(x), acos((double)x)));
        asin_error = larger(asin_error, fabs((double)P_asin(x) - asin((double)x)));
        atan_error = larger(atan_error, fabs((double)P_atan2(y, x) - atan2((double)y, (double)x)));
        atan_ulp = larger(atan_ulp, ulps(P_atan2(y, x), atan2((double)y, (double)x)));
    }
    print_message("acos %.3g (%.2f ulp), asin %.3g, atan2 %.3g (%.2f ulp)\n", acos_error, acos_ulp, asin_error,
                  atan_error, atan_ulp);
    assert_true(acos_error < 3.1e-7 && acos_ulp < 1.5 && asin_error < 3e-7 && atan_error < 4e-7 && atan_ulp < 3.5);
    assert_true(P_acos(1.0f) == 0.0f && P_acos(2.0f) == 0.0f && P_asin(0.0f) == 0.0f);
    assert_near(P_acos(-5.0f), PI, 2e-7);
}

/* Zeros and infinities of both signs, as C defines them. */
static void atan2_takes_zeros_and_infinities_as_c_does(void **state)
{
    const float values[] = { 0.0f, -0.0f, 1.0f, -1.0f, 1e-45f, 3e38f, P_from_bits(0x7f800000u),
                             P_from_bits(0xff800000u) };
    size_t i, k;
    (void)state;
    for (i = 0; i < 8; i++) {
        for (k = 0; k < 8; k++) {
            float a = P_atan2(values[i], values[k]);
            double b = atan2((double)values[i], (double)values[k]);
            assert_near(a, b, 4e-7);
            assert_int_equal(P_to_bits(a) >> 31, P_to_bits((float)b) >> 31);
        }
    }
}

static void exp_log_and_pow_keep_their_bounds(void **state)
{
    uint32_t i;
    double e = 0, l = 0, p = 0;
    (void)state;
    for (i = 0; i < 1000000; i++) {
        float x = uniform(5, i, -87, 88.7), y = P_exp(x), z = uniform(6, i, -10, 10);
        double power = pow((double)y, (double)z);
        e = larger(e, ulps(y, exp((double)x)));
        if (y != 1.0f) l = larger(l, ulps(P_log(y), log((double)y)));
        if (power > 1.2e-38 && power < 3.4e38) p = larger(p, ulps(P_pow(y, z), power));
    }
    print_message("exp %.3f, log %.3f, pow %.3f ulp\n", e, l, p);
    assert_true(e < 0.51 && l < 0.51 && p < 0.51);
    assert_true(P_exp(0.0f) == 1.0f && P_log(1.0f) == 0.0f && P_exp(-200.0f) == 0.0f);
    assert_false(P_finite(P_exp(89.0f)));
    assert_true(P_exp(88.722f) > 3.3e38f && P_finite(P_exp(88.7228f)));
    assert_false(P_finite(P_log(0.0f)) || P_finite(P_log(-1.0f)));
    assert_near(P_log(1e-45f), log((double)1e-45f), 1e-4);
    assert_true(P_pow(0.0f, 2.0f) == 0.0f && P_pow(-3.0f, 2.0f) == 0.0f && P_pow(0.0f, 0.0f) == 1.0f);
    assert_true(P_pow(7.0f, 0.0f) == 1.0f && P_pow(2.0f, 10.0f) == 1024.0f);
    assert_false(P_finite(P_pow(0.0f, -1.0f)) || P_finite(P_pow(10.0f, 39.0f)));
}

/* ---- bytes, crc, rng, lds ---- */

static void numbers_are_stored_little_endian(void **state)
{
    static const uint8_t expected[18] = { 0x34, 0x12, 0x78, 0x56, 0x34, 0x12, 8, 7, 6, 5, 4, 3, 2, 1,
                                          0, 0, 0xc0, 0x3f };
    uint16_t native;
    uint8_t b[18];
    (void)state;
    P_put_u16(b, 0x1234u);
    P_put_u32(b + 2, 0x12345678u);
    P_put_u64(b + 6, 0x0102030405060708u);
    P_put_f32(b + 14, 1.5f);
    assert_memory_equal(b, expected, sizeof b);
    assert_int_equal(P_get_u16(b), 0x1234);
    assert_int_equal(P_get_u32(b + 2), 0x12345678);
    assert_true(P_get_u64(b + 6) == 0x0102030405060708u);
    assert_true(P_get_f32(b + 14) == 1.5f);
    memcpy(&native, b, sizeof native);
    assert_int_equal(P_host_is_little_endian(), native == 0x1234u);
}

static void crc32_has_its_check_value(void **state)
{
    (void)state;
    assert_true(P_crc32(0, "123456789", 9) == 0xcbf43926u);
    assert_true(P_crc32(P_crc32(0, "1234", 4), "56789", 5) == 0xcbf43926u);
    assert_true(P_crc32(0, "", 0) == 0);
}

/* Chi-square statistic of counts against expected shares, as a normal deviate (Wilson and Hilferty). */
static double chi_square_deviate(const uint32_t *counts, const double *shares, uint32_t cells, double total)
{
    double sum = 0, freedom = -1, third;
    uint32_t i;
    for (i = 0; i < cells; i++) {
        double expected = shares ? shares[i] * total : total / cells;
        if (expected <= 0) continue;
        sum += ((double)counts[i] - expected) * ((double)counts[i] - expected) / expected;
        freedom++;
    }
    third = 2.0 / (9.0 * freedom);
    return (cbrt(sum / freedom) - (1.0 - third)) / sqrt(third);
}

static void random_numbers_are_uniform(void **state)
{
    static uint32_t counts[3][1024];
    P_rng r = P_rng_make(1), s = P_rng_make(1);
    uint32_t i, k;
    (void)state;
    memset(counts, 0, sizeof counts);
    for (i = 0; i < 1u << 20; i++) {
        float a = P_rng_float(&r), b = P_rng_float(&r), c = P_random(1, 2, i);
        assert_true(a >= 0.0f && a < 1.0f && c >= 0.0f && c < 1.0f);
        counts[0][(int)(a * 32) * 32 + (int)(b * 32)]++;
        counts[1][(int)(c * 32) * 32 + (int)(P_random(1, 3, i) * 32)]++;
        counts[2][(int)(c * 32) * 32 + (int)(P_random(2, 2, i) * 32)]++;
    }
    for (k = 0; k < 3; k++) assert_true(fabs(chi_square_deviate(counts[k], NULL, 1024, 1048576.0)) < 3.3);
    for (i = 0; i < 10; i++) assert_true(P_rng_u32(&s) != P_hash32(i));
    assert_true(P_to_unit(0xffffffffu) == LARGEST_BELOW_1 && P_to_unit(255) == 0.0f);
    assert_true(P_hash_combine(1, 2) != P_hash_combine(2, 1));
}

static void radical_inverses_mirror_the_digits(void **state)
{
    (void)state;
    assert_true(P_radical2(0) == 0.0f && P_radical2(1) == 0.5f && P_radical2(6) == 0.375f);
    assert_true(P_radical2(0xffffffffu) == LARGEST_BELOW_1 && P_radical3(3486784400u) == LARGEST_BELOW_1);
    assert_near(P_radical3(1), 1.0 / 3, 1e-7);
    assert_near(P_radical3(5), 7.0 / 9, 1e-7);
    assert_near(P_radical3(26), 26.0 / 27, 1e-7);
}

/* A (0, 2)-sequence puts one of its first 2^n points into every box of area 2^-n; scrambling keeps that. */
static void sobol_points_fill_every_box_of_their_area(void **state)
{
    static uint8_t hit[1024];
    uint32_t seed, n, a, i;
    (void)state;
    for (seed = 0; seed < 8; seed++) {
        for (n = 2; n <= 10; n += 4) {
            for (a = 0; a <= n; a++) {
                memset(hit, 0, sizeof hit);
                for (i = 0; i < 1u << n; i++) {
                    float u, v;
                    uint32_t box;
                    P_sobol2(i, seed, &u, &v);
                    assert_true(u >= 0.0f && u < 1.0f && v >= 0.0f && v < 1.0f);
                    box = (uint32_t)(u * (float)(1u << a)) << (n - a) | (uint32_t)(v * (float)(1u << (n - a)));
                    assert_int_equal(hit[box], 0);
                    hit[box] = 1;
                }
            }
        }
    }
}

/* Points fill the square evenly: no cell of a 16 x 16 grid is far from its share of 4096. */
static void r2_points_fill_the_square_evenly(void **state)
{
    uint32_t counts[256], i;
    (void)state;
    memset(counts, 0, sizeof counts);
    for (i = 0; i < 4096; i++) {
        float u, v;
        P_r2(i, &u, &v);
        assert_true(u >= 0.0f && u < 1.0f && v >= 0.0f && v < 1.0f);
        counts[(int)(u * 16) * 16 + (int)(v * 16)]++;
    }
    for (i = 0; i < 256; i++) assert_in_range(counts[i], 12, 20);
}

/* ---- hilbert (T65): a bijection with distance 1 between neighbours ---- */

static void t65_neighbours_on_a_hilbert_curve_are_one_apart(void **state)
{
    uint32_t dims, bits;
    (void)state;
    for (dims = 1; dims <= 3; dims++) {
        for (bits = 0; bits <= 6; bits++) {
            uint32_t count = 1u << (dims * bits), i, k, last[3] = { 0, 0, 0 }, cell[3] = { 0, 0, 0 };
            for (i = 0; i < count; i++) {
                int distance = 0;
                P_hilbert_cell(i, bits, dims, cell);
                for (k = 0; k < dims; k++) {
                    assert_true(cell[k] < 1u << bits);
                    distance += abs((int)cell[k] - (int)last[k]);
                    last[k] = cell[k];
                }
                assert_int_equal(distance, i > 0);
                assert_int_equal(P_hilbert_index(cell, bits, dims), i);     /* so no cell comes twice */
            }
        }
    }
}

/* ---- octa ---- */

static void points_of_the_octahedral_map_come_back(void **state)
{
    uint32_t i;
    double worst = 0, worst_length = 0;
    (void)state;
    for (i = 0; i < 300000; i++) {
        float u = P_random(9, 1, i), v = P_random(9, 2, i), a, b;
        P_v3 d = P_octa_direction(u, v);
        P_octa_square(d, &a, &b);
        worst = larger(worst, larger(fabs((double)a - (double)u), fabs((double)b - (double)v)));
        worst_length = larger(worst_length, fabs((double)P_v3_length(d) - 1.0));
    }
    print_message("octa: round trip %.3g, length %.3g\n", worst, worst_length);
    assert_true(worst < 2e-6 && worst_length < 5e-7);
}

/* Centre, middles of the sides and corners, and -0 in every place. */
static void axes_lie_at_the_middles_and_corners_of_the_octahedral_map(void **state)
{
    static const float axes[6][3] = { { 0, 1, 0 }, { 1, 0, 0 }, { 0, 0, 1 }, { -1, 0, 0 }, { 0, 0, -1 }, { 0, -1, 0 } };
    P_v3 up = P_octa_direction(0.5f, 0.5f), side = P_octa_direction(1.0f, 0.5f), down = P_octa_direction(0.0f, 1.0f);
    int i, signs;
    (void)state;
    assert_true(up.y == 1.0f && up.x == 0.0f && up.z == 0.0f);
    assert_near(side.x, 1.0f, 1e-7f);
    assert_near(down.y, -1.0f, 1e-7f);
    for (i = 0; i < 6; i++) {
        for (signs = 0; signs < 8; signs++) {
            P_v3 n = P_v3_load(axes[i]), d;
            float u, v;
            if (n.x == 0.0f && signs & 1) n.x = -0.0f;
            if (n.y == 0.0f && signs & 2) n.y = -0.0f;
            if (n.z == 0.0f && signs & 4) n.z = -0.0f;
            P_octa_square(n, &u, &v);
            assert_true(u >= 0.0f && u <= 1.0f && v >= 0.0f && v <= 1.0f);
            d = P_octa_direction(u, v);
            assert_near(P_v3_length(P_v3_sub(d, n)), 0, 1e-6f);
        }
    }
}

/* Solid angle of each cell of a 16 x 16 grid by the cross product of the derivatives, summed over 8 x 8 points. */
static void cells_of_the_octahedral_map_have_equal_areas(void **state)
{
    int x, y, i, k;
    (void)state;
    for (y = 0; y < 16; y++) {
        for (x = 0; x < 16; x++) {
            double area = 0;
            for (k = 0; k < 8; k++) {
                for (i = 0; i < 8; i++) {
                    float u = ((float)x + ((float)i + 0.5f) / 8.0f) / 16.0f;
                    float v = ((float)y + ((float)k + 0.5f) / 8.0f) / 16.0f;
                    float h = 1.0f / 1024.0f;
                    P_v3 du = P_v3_sub(P_octa_direction(u + h, v), P_octa_direction(u - h, v));
                    P_v3 dv = P_v3_sub(P_octa_direction(u, v + h), P_octa_direction(u, v - h));
                    area += (double)P_v3_length(P_v3_cross(du, dv)) / (4.0 * 64.0) * (64.0 * 64.0);
                }
            }
            assert_near(area, 4 * PI / 256, 4 * PI / 256 * 0.002);
        }
    }
}

/* ---- cdf (T15, T16, T22) ---- */

static void of_two_cells_the_empty_one_is_never_chosen(void **state)
{
    const float weights[2] = { 0.0f, 1.0f };
    double sums[3];
    P_cdf cdf;
    uint32_t i;
    (void)state;
    assert_int_equal(P_cdf_doubles(2), 3);
    assert_int_equal(P_cdf_build(&cdf, sums, weights, 2, 1.0), 0);
    for (i = 0; i < 65536; i++) assert_int_equal(P_cdf_sample_at(&cdf, P_random(1, 1, i)).index, 1);
    assert_int_equal(P_cdf_sample_at(&cdf, 0.0f).index, 1);
    assert_int_equal(P_cdf_sample_at(&cdf, LARGEST_BELOW_1).index, 1);
    assert_int_equal(P_cdf_sample_at(&cdf, -1.0f).index, 1);
    assert_int_equal(P_cdf_sample_at(&cdf, 2.0f).index, 1);
    assert_near(P_cdf_sample_at(&cdf, 0.25f).fraction, 0.25f, 1e-7f);
    assert_true(P_cdf_sample_at(&cdf, 0.25f).probability == 1.0f && P_cdf_probability(&cdf, 0) == 0.0f);
}

/* Leading, inner and trailing empty cells at every u, also with a total so small that products round. */
static void empty_cells_are_never_chosen_at_any_scale(void **state)
{
    static const float scales[3] = { 1.0f, 1e-44f, 3e38f };
    uint32_t i, k;
    (void)state;
    for (k = 0; k < 3; k++) {
        float weights[9] = { 0, 0, 1, 0, 0, 1, 1, 0, 0 };
        double sums[10];
        P_cdf cdf;
        for (i = 0; i < 9; i++) weights[i] *= scales[k];
        P_cdf_build(&cdf, sums, weights, 9, k == 1 ? 1e-279 : 1.0);
        for (i = 0; i <= 30000; i++) {
            P_cdf_sample s = P_cdf_sample_at(&cdf, i == 30000 ? LARGEST_BELOW_1 : (float)i / 30000.0f);
            assert_true(s.index < 9 && weights[s.index] > 0.0f);
            assert_true(s.fraction >= 0.0f && s.fraction < 1.0f && s.probability > 0.0f);
        }
    }
}

static void bad_weights_are_counted_and_never_chosen(void **state)
{
    const float weights[7] = { 1.0f, -2.0f, P_from_bits(0x7fc00000u), P_from_bits(0x7f800000u),
                               P_from_bits(0xff800000u), 3.0f, -0.0f };
    const float none[3] = { 0.0f, -1.0f, -0.0f };
    double sums[8];
    P_cdf cdf;
    uint32_t i;
    (void)state;
    assert_int_equal(P_cdf_build(&cdf, sums, weights, 7, 1.0), 4);
    assert_true(P_cdf_total(&cdf) == 4.0);
    for (i = 0; i < 10000; i++) {
        uint32_t index = P_cdf_sample_at(&cdf, P_random(3, 1, i)).index;
        assert_true(index == 0 || index == 5);
    }
    assert_int_equal(P_cdf_build(&cdf, sums, none, 3, 1.0), 1);
    assert_true(P_cdf_sample_at(&cdf, 0.5f).probability == 0.0f && P_cdf_probability(&cdf, 1) == 0.0f);
}

/* Float running sums give 1.009 for the first and 1000.0 for the second. */
static void a_million_small_weights_add_up(void **state)
{
    const uint32_t n = 1000000;
    float *weights = (float *)malloc((n + 1) * sizeof *weights);
    double *sums = (double *)malloc(P_cdf_doubles(n + 1) * sizeof *sums);
    P_cdf cdf;
    uint32_t i;
    (void)state;
    assert_true(weights && sums);
    for (i = 0; i < n; i++) weights[i] = 1e-6f;
    P_cdf_build(&cdf, sums, weights, n, 1.0);
    assert_near(P_cdf_total(&cdf), 1.0, 1e-7);
    weights[0] = 1000.0f;
    for (i = 1; i <= n; i++) weights[i] = 1e-5f;
    P_cdf_build(&cdf, sums, weights, n + 1, 1.0);
    assert_near(P_cdf_total(&cdf), 1010.0, 1e-5);
    free(sums);
    free(weights);
}

static void a_table_is_sampled_by_its_weights(void **state)
{
    enum { W = 64, H = 32, N = 1 << 20 };
    static float weights[W * H], scale[H];
    static double memory[(W + 1) * H + H + 1], shares[W * H];
    static uint32_t counts[W * H];
    P_cdf2 cdf;
    double total = 0, sum = 0;
    uint32_t i;
    (void)state;
    for (i = 0; i < W * H; i++) {
        weights[i] = i % 7 == 3 || i / W == 5 ? 0.0f : 0.2f + P_random(4, 1, i);
        scale[i / W] = 0.5f + (float)(i / W % 3);
        shares[i] = (double)weights[i] * (double)scale[i / W];
        total += shares[i];
    }
    assert_int_equal(P_cdf2_doubles(W, H), sizeof memory / sizeof memory[0]);
    assert_int_equal(P_cdf2_build(&cdf, memory, weights, scale, W, H), 0);
    assert_near(P_cdf2_total(&cdf), total, 1e-9 * total);
    for (i = 0; i < W * H; i++) {
        shares[i] /= total;
        sum += (double)P_cdf2_probability(&cdf, i % W, i / W);
        assert_near(P_cdf2_probability(&cdf, i % W, i / W), shares[i], 1e-9);
    }
    assert_near(sum, 1.0, 1e-6);
    memset(counts, 0, sizeof counts);
    for (i = 0; i < N; i++) {
        P_cdf2_sample s = P_cdf2_sample_at(&cdf, P_random(5, 1, i), P_random(5, 2, i));
        assert_true(s.fx >= 0.0f && s.fx < 1.0f && s.fy >= 0.0f && s.fy < 1.0f);
        assert_true(s.probability == P_cdf2_probability(&cdf, s.x, s.y) && s.probability > 0.0f);
        counts[s.y * W + s.x]++;
    }
    for (i = 0; i < W * H; i++) assert_true(counts[i] == 0 || weights[i] > 0.0f);
    assert_true(chi_square_deviate(counts, shares, W * H, N) < 3.09);       /* p > 0.001 */
}

static void tables_that_are_too_large_have_no_size(void **state)
{
    (void)state;
    assert_int_equal(P_cdf2_doubles(1, 1), 4);
    assert_true(P_cdf_doubles(SIZE_MAX) == 0 && P_cdf_doubles(SIZE_MAX / 8) == 0);
    assert_true(P_cdf2_doubles(0xffffffffu, 0xffffffffu) == 0);
}

static void avx512_comes_with_avx2(void **state)
{
    (void)state;
    assert_true(!P_cpu_has_avx512() || P_cpu_has_avx2());
    print_message("avx2 %d, avx512 %d\n", P_cpu_has_avx2(), P_cpu_has_avx512());
}

/* ---- arguments, bits, part, batch ---- */

static void strides_and_ranges_are_checked(void **state)
{
    (void)state;
    assert_true(P_stride_valid(0, 12) && P_stride_valid(12, 12) && P_stride_valid(16, 12) && P_stride_valid(4, 4));
    assert_false(P_stride_valid(8, 12) || P_stride_valid(13, 12) || P_stride_valid(4, 12));
    assert_true(P_in(0, 0, 1) && P_in(1, 0, 1) && P_in(-0.0f, 0, 1));
    assert_false(P_in(-1e-30f, 0, 1) || P_in(1.5f, 0, 1) || P_in(NAN, 0, 1) || P_in(INFINITY, 0, INFINITY));
}

static void every_bit_is_counted(void **state)
{
    int bit, i;
    (void)state;
    assert_int_equal(P_popcount(0), 0);
    assert_int_equal(P_popcount(~(uint64_t)0), 64);
    for (i = 0; i < 10000; i++) {
        uint64_t x = (uint64_t)P_hash32((uint32_t)i) << 32 | P_hash32((uint32_t)i + 77777u);
        uint32_t count = 0;
        for (bit = 0; bit < 64; bit++) count += (uint32_t)(x >> bit & 1);
        assert_int_equal(P_popcount(x), count);
    }
}

static float told;
static int calls;

static int tell(void *user, float fraction)
{
    told = fraction;
    calls++;
    return user != NULL;
}

static void a_part_reports_its_share_of_progress(void **state)
{
    P_part whole = { tell, NULL, 0, 1 }, half, quarter, silent = { NULL, NULL, 0, 1 };
    size_t i;
    (void)state;
    half = P_part_of(&whole, 0.5f, 1);
    quarter = P_part_of(&half, 0, 0.5f);
    assert_true(quarter.from >= 0.5f && quarter.from <= 0.5f && quarter.to >= 0.75f && quarter.to <= 0.75f);
    for (i = 0; i < 100; i++) assert_false(P_cancelled(&quarter, i, 100, 10) || P_cancelled(&silent, i, 100, 1));
    assert_int_equal(calls, 10);
    assert_near(told, 0.5 + 0.25 * 0.9, 1e-6);
    quarter.user = &calls;
    assert_true(P_cancelled(&quarter, 20, 100, 10));
    assert_false(P_cancelled(&quarter, 21, 100, 10));
}

static void take_index(void *context, size_t index) { *(size_t *)context = index; }

static void a_task_of_a_batch_begins_at_its_start(void **state)
{
    size_t index = 0;
    P_batch batch = { take_index, NULL, 100 };
    (void)state;
    batch.context = &index;
    P_batch_task(&batch, 7);
    assert_int_equal(index, 107);
}

/* Two triangles that share an edge walk it in opposite directions: one of them owns it, whatever its slope. */
static void one_of_two_triangles_owns_an_edge(void **state)
{
    (void)state;
    for (int dx = -3; dx <= 3; dx++)
        for (int dy = -3; dy <= 3; dy++)
            if (dx || dy) assert_int_equal(P_edge_owns(dx, dy) + P_edge_owns(-dx, -dy), 1);
    assert_true(P_edge_owns(0, -1));            /* the edge of a triangle that lies to the right of it */
    assert_true(P_edge_owns(1, 0));
}

/* Points of a triangle in space, seen in perspective and parallel, from both sides: the weights that made the point. A
   sample off the triangle gets a point of its edge. */
static void weights_at_a_sample_are_those_of_the_point(void **state)
{
    static const double corner[2][9] = { { -1, 2, 3, 4, -1, 2, 0, -3, 7 }, { -1, 2, 1, 4, -1, 1, 0, -3, 1 } };
    static const double off[2] = { 30, 40 };
    double c[9], p[3];
    float w[3];
    int view, turned, i, j, k;
    (void)state;
    for (view = 0; view < 2; view++)
        for (turned = 0; turned < 2; turned++) {
            for (k = 0; k < 9; k++) c[k] = corner[view][turned ? (8 - k) / 3 * 3 + k % 3 : k];
            for (i = 0; i <= 8; i++)
                for (j = 0; i + j <= 8; j++) {
                    double a = i / 8.0, b = j / 8.0;
                    for (k = 0; k < 3; k++) p[k] = (1 - a - b) * c[k] + a * c[3 + k] + b * c[6 + k];
                    P_mask_weights(c, p[0] / p[2], p[1] / p[2], w);
                    assert_true(fabs((double)w[0] - (1 - a - b)) < 1e-6 && fabs((double)w[1] - a) < 1e-6);
                    assert_true(fabs((double)w[2] - b) < 1e-6);
                }
            P_mask_weights(c, off[0], off[1], w);
            for (k = 0; k < 3; k++) assert_true(w[k] >= 0 && w[k] <= 1);
            assert_true(fabs((double)(w[0] + w[1] + w[2]) - 1) < 1e-6);
            assert_true(!(w[0] > 0) || !(w[1] > 0) || !(w[2] > 0));
        }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(weights_at_a_sample_are_those_of_the_point),
        cmocka_unit_test(sizes_that_overflow_are_refused), cmocka_unit_test(tiny_and_huge_vectors_normalise),
        cmocka_unit_test(infinities_and_nans_are_not_finite), cmocka_unit_test(lengths_of_0_97_to_1_03_count_as_unit),
        cmocka_unit_test(a_basis_is_orthonormal_and_right_handed), cmocka_unit_test(vectors_add_scale_and_multiply),
        cmocka_unit_test(an_inverse_undoes_its_matrix_or_fails),
        cmocka_unit_test(sixteen_zeros_stand_for_the_identity),
        cmocka_unit_test(rotations_times_a_scale_are_told_apart), cmocka_unit_test(sin_and_cos_keep_their_bounds),
        cmocka_unit_test(asin_acos_and_atan2_keep_their_bounds),
        cmocka_unit_test(atan2_takes_zeros_and_infinities_as_c_does),
        cmocka_unit_test(exp_log_and_pow_keep_their_bounds), cmocka_unit_test(numbers_are_stored_little_endian),
        cmocka_unit_test(crc32_has_its_check_value), cmocka_unit_test(random_numbers_are_uniform),
        cmocka_unit_test(radical_inverses_mirror_the_digits),
        cmocka_unit_test(sobol_points_fill_every_box_of_their_area),
        cmocka_unit_test(r2_points_fill_the_square_evenly),
        cmocka_unit_test(t65_neighbours_on_a_hilbert_curve_are_one_apart),
        cmocka_unit_test(points_of_the_octahedral_map_come_back),
        cmocka_unit_test(axes_lie_at_the_middles_and_corners_of_the_octahedral_map),
        cmocka_unit_test(cells_of_the_octahedral_map_have_equal_areas),
        cmocka_unit_test(of_two_cells_the_empty_one_is_never_chosen),
        cmocka_unit_test(empty_cells_are_never_chosen_at_any_scale),
        cmocka_unit_test(bad_weights_are_counted_and_never_chosen), cmocka_unit_test(a_million_small_weights_add_up),
        cmocka_unit_test(a_table_is_sampled_by_its_weights), cmocka_unit_test(tables_that_are_too_large_have_no_size),
        cmocka_unit_test(avx512_comes_with_avx2), cmocka_unit_test(strides_and_ranges_are_checked),
        cmocka_unit_test(every_bit_is_counted), cmocka_unit_test(a_part_reports_its_share_of_progress),
        cmocka_unit_test(a_task_of_a_batch_begins_at_its_start), cmocka_unit_test(one_of_two_triangles_owns_an_edge)
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
