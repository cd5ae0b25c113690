/* simd_test - kernels give the same bits in every instruction set and whatever a lane is: unit simd of src/shared. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <math.h>
#include <cmocka.h>

#ifdef RSM_NO_SIMD
#define P_NO_SIMD
#endif
#define P_FILE "simd_kernels.h"
#include "src/shared/fp_begin.h"
#include "src/shared/cpu.h"
#include "src/shared/bits.h"
#include "src/shared/simd.h"

/* What the program is compiled for, by one vector, two and four. */
#define P_SET one_plain
#define P_WIDTH P_SIMD_WIDTH
#define P_LANE_COUNT 4
#include "simd_kernels.h"
#define P_SET two_plain
#define P_WIDTH P_SIMD_WIDTH
#define P_LANE_COUNT 8
#include "simd_kernels.h"
#define P_SET four_plain
#define P_WIDTH P_SIMD_WIDTH
#define P_LANE_COUNT 16
#include "simd_kernels.h"
#if P_SIMD_SETS
#define P_SET one_avx2
#define P_WIDTH 8
#define P_LANE_COUNT 8
#include "simd_kernels.h"
#define P_SET two_avx2
#define P_WIDTH 8
#define P_LANE_COUNT 16
#include "simd_kernels.h"
#define P_SET one_avx512
#define P_WIDTH 16
#define P_LANE_COUNT 16
#include "simd_kernels.h"
#endif

/* What other processors than x86 compile: the compiler's vectors, and floats. */
#undef P_SIMD_X86
#define P_SIMD_X86 0
#if (defined(__GNUC__) || defined(__clang__)) && !defined(__TINYC__)
#undef P_SIMD_VECTORS
#define P_SIMD_VECTORS 1
#define P_SET vectors
#define P_WIDTH 4
#define P_LANE_COUNT 16
#include "simd_kernels.h"
#define HAVE_VECTORS 1
#else
#define HAVE_VECTORS 0
#endif
#undef P_SIMD_VECTORS
#define P_SIMD_VECTORS 0
#define P_SET floats
#define P_WIDTH 1
#define P_LANE_COUNT 16
#include "simd_kernels.h"
#undef simd_compute
#undef simd_muladd
#undef simd_bits
#undef simd_integers
#undef simd_append
#undef simd_words
#undef simd_unpack
#undef simd_order

typedef struct set {
    const char *name;
    int lanes, level, fused;    /* level: what P_simd_level must say */
    void (*compute)(const float *a, const float *b, float *out);
    void (*muladd)(const float *a, const float *b, const float *c, float *out);
    uint32_t (*bits)(const float *a, const float *b);
    void (*integers)(const int32_t *a, const int32_t *b, int32_t *out);
    uint32_t (*append)(const float *a, const float *b, float *list, int32_t *numbers);
    void (*words)(uint64_t bits, uint32_t number, const uint32_t *words, uint32_t limit, uint32_t out[3]);
    void (*unpack)(const float *xyz, size_t stride, float *out);
} set;

static const set sets[] = {
    { "one vector of the program's", 4, 0, 0, simd_compute_one_plain, simd_muladd_one_plain, simd_bits_one_plain,
      simd_integers_one_plain, simd_append_one_plain, simd_words_one_plain,
      simd_unpack_one_plain },
    { "two of the program's", 8, 0, 0, simd_compute_two_plain, simd_muladd_two_plain, simd_bits_two_plain,
      simd_integers_two_plain, simd_append_two_plain, simd_words_two_plain,
      simd_unpack_two_plain },
    { "four of the program's", 16, 0, 0, simd_compute_four_plain, simd_muladd_four_plain, simd_bits_four_plain,
      simd_integers_four_plain, simd_append_four_plain, simd_words_four_plain,
      simd_unpack_four_plain },
#if P_SIMD_SETS
    { "AVX2", 8, 1, 1, simd_compute_one_avx2, simd_muladd_one_avx2, simd_bits_one_avx2,
      simd_integers_one_avx2, simd_append_one_avx2, simd_words_one_avx2,
      simd_unpack_one_avx2 },
    { "two of AVX2", 16, 1, 1, simd_compute_two_avx2, simd_muladd_two_avx2, simd_bits_two_avx2,
      simd_integers_two_avx2, simd_append_two_avx2, simd_words_two_avx2,
      simd_unpack_two_avx2 },
    { "AVX-512", 16, 2, 1, simd_compute_one_avx512, simd_muladd_one_avx512, simd_bits_one_avx512,
      simd_integers_one_avx512, simd_append_one_avx512, simd_words_one_avx512,
      simd_unpack_one_avx512 },
#endif
#if HAVE_VECTORS
    { "the compiler's vectors", 16, 0, 0, simd_compute_vectors, simd_muladd_vectors, simd_bits_vectors,
      simd_integers_vectors, simd_append_vectors, simd_words_vectors,
      simd_unpack_vectors },
#endif
    { "floats", 16, 0, 0, simd_compute_floats, simd_muladd_floats, simd_bits_floats,
      simd_integers_floats, simd_append_floats, simd_words_floats,
      simd_unpack_floats }
};

enum { VALUES = 16, SET_COUNT = sizeof sets / sizeof *sets };

/* Numbers with and without fractions, both zeros, the largest that truncate; every pair of lanes meets by turning b. */
static const float values[VALUES] = { 0.0f,  -0.0f,  1.0f,    -1.0f, 0.3f,      -0.7f,    2.5f,        -2.5f,
                                      1e-3f, 1e6f,   -3e7f,   7.0f,  16777216.f, -1234.5f, 2147483000.f, 1e-20f };

static float expected(int plane, float a, float b)
{
    const int greater = a > b;
    volatile int32_t whole = (int32_t)a;        /* volatile: gcc on s390x else makes -0 of (float)(int32_t)-0.0f */
    switch (plane) {
    case SIMD_ADD: return a + b;
    case SIMD_SUB: return a - b;
    case SIMD_MUL: return a * b;
    case SIMD_DIV: return a / b;
    case SIMD_MAX: return greater ? a : b;
    case SIMD_MIN: return a < b ? a : b;
    case SIMD_SQRT: return sqrtf(fabsf(a));
    case SIMD_ABS: return fabsf(a);
    case SIMD_NEGATE: return -a;
    case SIMD_GREATER: return greater ? 1.0f : 0.0f;
    case SIMD_AT_LEAST: return a >= b ? 1.0f : 0.0f;
    case SIMD_DIFFER: return a != b ? 1.0f : 0.0f;
    case SIMD_SELECT: return greater ? a : b;
    case SIMD_KEEP: return greater ? a : 0.0f;
    case SIMD_AND: return a >= b && a != b ? 1.0f : 0.0f;
    case SIMD_OR: return greater || b > 1.0f ? 1.0f : 0.0f;
    case SIMD_TRUNCATE: return (float)whole;
    case SIMD_INTS: return (float)(((int32_t)a + (7 - (greater ? 2 : 0))) | 1);
    default: return a * (a - 0.25f) + b * (b - 0.5f) + a * (a - 2.0f);
    }
}

static int can_run(const set *s) { return P_simd_level() >= s->level; }

/* The same bits; any bits of what is not a number. */
static int same(float a, float b)
{
    return memcmp(&a, &b, sizeof a) == 0 || (a != a && b != b);
}

static void every_set_computes_what_c_says(void **state)
{
    float a[VALUES], b[VALUES], out[SIMD_PLANE_COUNT * VALUES];
    int s, turn, first, plane, l;
    (void)state;
    for (s = 0; s < SET_COUNT; s++) {
        const int lanes = sets[s].lanes;
        for (turn = 0; turn < VALUES && can_run(&sets[s]); turn++)
            for (first = 0; first < VALUES; first += lanes) {
                for (l = 0; l < lanes; l++) {
                    a[l] = values[first + l];
                    b[l] = values[(first + l + turn) % VALUES];
                }
                sets[s].compute(a, b, out);
                for (plane = 0; plane < SIMD_PACKED; plane++)
                    for (l = 0; l < lanes; l++)
                        if (!same(out[plane * lanes + l], expected(plane, a[l], b[l])))
                            fail_msg("%s, plane %d: %g and %g make %.9g, not %.9g", sets[s].name, plane, (double)a[l],
                                     (double)b[l], (double)out[plane * lanes + l], (double)expected(plane, a[l], b[l]));
            }
    }
}

static void vectors_of_three_are_packed_lane_by_lane(void **state)
{
    float a[VALUES], b[VALUES], out[SIMD_PLANE_COUNT * VALUES];
    int s, l;
    (void)state;
    for (l = 0; l < VALUES; l++) {
        a[l] = (float)l + 1.0f;
        b[l] = -(float)l - 1.0f;
    }
    for (s = 0; s < SET_COUNT; s++) {
        const float *packed = out + SIMD_PACKED * sets[s].lanes;
        if (!can_run(&sets[s])) continue;
        sets[s].compute(a, b, out);
        for (l = 0; l < sets[s].lanes; l++)
            assert_true(packed[3 * l] == a[l] && packed[3 * l + 1] == b[l] && packed[3 * l + 2] == a[l] - 0.25f);
    }
}

static void shorts_places_bits_and_equal_ints_are_those_of_each_lane(void **state)
{
    float out[SIMD_PLANE_COUNT * VALUES];
    int s, l;
    (void)state;
    for (s = 0; s < SET_COUNT; s++) {
        const int lanes = sets[s].lanes;
        if (!can_run(&sets[s])) continue;
        sets[s].compute(values, values, out);
        for (l = 0; l < lanes; l++) {
            const int other = (5 * l + 3) % lanes;
            assert_true(out[SIMD_SHORTS * lanes + l] == (float)(4000 * l - 32767));
            assert_true(same(out[SIMD_GATHER * lanes + l], values[other]));
            assert_true(out[SIMD_OF_BITS * lanes + l] == (float)(SIMD_BITS >> l & 1u));
            assert_true(out[SIMD_EQUAL * lanes + l] == (other == 3 ? 1.0f : 0.0f));
        }
    }
}

static void bytes_halves_fours_and_turned_squares_come_in_their_order(void **state)
{
    static const struct { int level; void (*order)(const float *, const uint8_t *, float *); } sets16[] = {
        { 0, simd_order_four_plain },
#if P_SIMD_SETS
        { 1, simd_order_two_avx2 },
        { 2, simd_order_one_avx512 },
#endif
#if HAVE_VECTORS
        { 0, simd_order_vectors },
#endif
        { 0, simd_order_floats }
    };
    float a[64], out[144];
    uint8_t bytes[16];
    size_t s;
    int l;
    (void)state;
    for (l = 0; l < 64; l++) a[l] = (float)l + 0.5f;
    for (l = 0; l < 16; l++) bytes[l] = (uint8_t)(255 - 17 * l);
    for (s = 0; s < sizeof sets16 / sizeof *sets16; s++) {
        if (P_simd_level() < sets16[s].level) continue;
        sets16[s].order(a, bytes, out);
        for (l = 0; l < 16; l++) {
            assert_true(out[l] == (float)bytes[l]);
            assert_true(out[16 + l] == (l < 8 ? a[3 + l] : a[21 + l - 8]));
            assert_true(out[32 + l] == a[1 + 3 * (l / 4)]);
            assert_true(out[48 + l] == a[l ^ 1]);
            assert_true(out[64 + l] == a[l ^ 2]);
        }
        for (l = 0; l < 64; l++) assert_true(out[80 + l] == a[l % 8 * 8 + l / 8]);
    }
}

static void what_is_not_a_number_loses_every_comparison(void **state)
{
    float a[VALUES], b[VALUES], out[SIMD_PLANE_COUNT * VALUES];
    int s, l;
    (void)state;
    for (s = 0; s < SET_COUNT; s++) {
        const int lanes = sets[s].lanes;
        if (!can_run(&sets[s])) continue;
        for (l = 0; l < lanes; l++) {
            a[l] = l % 2 ? NAN : 1.0f;
            b[l] = l % 2 ? 2.0f : NAN;
        }
        sets[s].compute(a, b, out);
        for (l = 0; l < lanes; l++) {
            assert_true(out[SIMD_GREATER * lanes + l] == 0.0f && out[SIMD_AT_LEAST * lanes + l] == 0.0f);
            assert_true(out[SIMD_DIFFER * lanes + l] == 1.0f);
            assert_true(same(out[SIMD_MAX * lanes + l], b[l]));
            assert_true(same(out[SIMD_MIN * lanes + l], b[l]));
        }
        assert_int_equal(sets[s].bits(a, b), 0);
    }
}

static void bits_of_a_mask_are_those_of_its_lanes(void **state)
{
    float a[VALUES], b[VALUES];
    int s, k, l;
    (void)state;
    for (s = 0; s < SET_COUNT; s++)
        for (k = 0; k < sets[s].lanes && can_run(&sets[s]); k++) {
            for (l = 0; l < sets[s].lanes; l++) {
                a[l] = l == k || l == 1 ? 1.0f : -1.0f;
                b[l] = 0.0f;
            }
            assert_int_equal(sets[s].bits(a, b), 0x80000000u | 1u << k | 2u);
        }
}

static int32_t half_of(int32_t a, int shift)
{
    const int32_t half = (int32_t)((uint32_t)a >> shift & 0xffffu);
    return half < 0x8000 ? half : half - 0x10000;
}

/* Of a quarter of each number, so that no product of halves passes 32 bits. */
static int32_t cross_of_quarters(int32_t a, int32_t b)
{
    const int32_t below_a = a < 0 && a % 4 != 0, below_b = b < 0 && b % 4 != 0;
    a = a / 4 - below_a;
    b = b / 4 - below_b;
    return half_of(a, 0) * half_of(b, 16) - half_of(b, 0) * half_of(a, 16);
}

static int32_t expected_integer(int plane, int32_t a, int32_t b)
{
    const int64_t wide_a = a, wide_b = b;       /* what passes 32 bits is cut off */
    const int32_t below = a < 0 && a % 32 != 0;
    switch (plane) {
    case SIMD_INTS_MUL: return (int32_t)(uint32_t)((uint64_t)(wide_a * wide_b) & 0xffffffffu);
    case SIMD_INTS_MIN: return a < b ? a : b;
    case SIMD_INTS_MAX: return a > b ? a : b;
    case SIMD_INTS_GREATER: return a > b;
    case SIMD_INTS_EQUAL: return a == b;
    case SIMD_INTS_SELECT: return a > b ? a : b;
    case SIMD_INTS_SHIFT: return a / 32 - below;
    case SIMD_INTS_AND: return (int32_t)((uint32_t)a & (uint32_t)b);
    case SIMD_INTS_XOR: return (int32_t)((uint32_t)a ^ (uint32_t)b);
    case SIMD_INTS_JOIN: return (int32_t)(((uint32_t)b & 0xffffu) << 16 | ((uint32_t)a & 0xffffu));
    case SIMD_INTS_CROSS: return cross_of_quarters(a, b);
    case SIMD_INTS_ADD: return (int32_t)(uint32_t)((uint64_t)(wide_a + wide_b) & 0xffffffffu);
    default: return (int32_t)(uint32_t)((uint64_t)(wide_a - wide_b) & 0xffffffffu);
    }
}

static void whole_numbers_are_those_of_c_and_wrap(void **state)
{
    static const int32_t numbers[VALUES] = { 0,   1,     -1,     7,          -7,        31,    32,         -32,
                                             -33, 65536, -65537, 2147483647, -2147483647 - 1, 46341,
                                             1000003, -1000003 };
    int32_t a[VALUES], b[VALUES], out[SIMD_INTS_COUNT * VALUES];
    int s, turn, first, plane, l;
    (void)state;
    for (s = 0; s < SET_COUNT; s++) {
        const int lanes = sets[s].lanes;
        for (turn = 0; turn < VALUES && can_run(&sets[s]); turn++)
            for (first = 0; first < VALUES; first += lanes) {
                for (l = 0; l < lanes; l++) {
                    a[l] = numbers[first + l];
                    b[l] = numbers[(first + l + turn) % VALUES];
                }
                sets[s].integers(a, b, out);
                for (l = 0; l < lanes; l++)
                    assert_int_equal(out[SIMD_INTS_GATHER * lanes + l], a[(uint32_t)b[l] & (uint32_t)(lanes - 1)]);
                for (plane = 0; plane < SIMD_INTS_GATHER; plane++)
                    for (l = 0; l < lanes; l++)
                        if (out[plane * lanes + l] != expected_integer(plane, a[l], b[l]))
                            fail_msg("%s, plane %d: %d and %d make %d, not %d", sets[s].name, plane, (int)a[l],
                                     (int)b[l], (int)out[plane * lanes + l],
                                     (int)expected_integer(plane, a[l], b[l]));
            }
    }
}

/* Every set of lanes, by the bits of a number. */
static void lanes_of_a_mask_are_appended_in_their_order(void **state)
{
    float a[VALUES], b[VALUES], list[2 * VALUES];
    int32_t numbers[2 * VALUES];
    uint32_t bits, count, answer, first;
    int s, l;
    (void)state;
    for (s = 0; s < SET_COUNT; s++)
        for (bits = 0; bits < 1u << sets[s].lanes && can_run(&sets[s]); bits++) {
            for (l = 0; l < sets[s].lanes; l++) {
                a[l] = (float)l;
                b[l] = bits >> l & 1u ? -1.0f : 99.0f;
            }
            answer = sets[s].append(a, b, list, numbers);
            for (first = 0; bits && !(bits >> first & 1u);) first++;
            for (l = 0, count = 0; l < sets[s].lanes; l++)
                if (bits >> l & 1u) {
                    assert_true(list[count] == (float)l && numbers[count] == l);
                    count++;
                }
            assert_int_equal(answer, count | first << 8);
        }
}

static void bits_are_counted_and_found_and_half_words_too(void **state)
{
    uint32_t words[64], out[3], number, limit, round, i, seed = 1;
    int s;
    (void)state;
    for (i = 0; i < 64; i++) words[i] = (1000u * i + 300u) | (1000u * i + 800u) << 16;  /* 300, 800, 1300, ... */
    for (s = 0; s < SET_COUNT; s++)
        for (round = 0; round < 64 && can_run(&sets[s]); round++) {
            uint64_t bits = 0;
            uint32_t count = 0, place = 64, below = 0;
            for (i = 0; i < 64; i++) {
                seed = seed * 1664525u + 1013904223u;
                bits |= (uint64_t)(seed >> 24 < 4u * round) << i;
            }
            number = round;
            limit = 513u * round + 7u;
            for (i = 0; i < 64; i++) {
                if (bits >> i & 1u && count++ == number) place = i;
                below += i < number && 500u * i + 300u <= limit;
            }
            sets[s].words(bits, number, words, limit, out);
            assert_int_equal(out[0], count);
            assert_int_equal(out[1], place);
            assert_int_equal(out[2], below);
        }
}

static void vectors_come_out_as_they_went_in(void **state)
{
    static const size_t strides[4] = { 3, 4, 5, 9 };        /* in floats */
    float in[9 * VALUES], out[3 * VALUES];
    size_t stride, i, k;
    int s;
    (void)state;
    for (i = 0; i < 9 * VALUES; i++) in[i] = (float)i - 7.0f;
    for (s = 0; s < SET_COUNT; s++)
        for (k = 0; k < 4 && can_run(&sets[s]); k++) {
            stride = strides[k];
            sets[s].unpack(in, 4 * stride, out);
            for (i = 0; i < 3 * (size_t)sets[s].lanes; i++)
                assert_true(out[i] == 2.0f * in[i / 3 * stride + i % 3]);
        }
}

static void muladd_rounds_once_in_avx_and_twice_elsewhere(void **state)
{
    const float third = 1.0f / 3.0f, rounded = third * 3.0f - 1.0f, fused = fmaf(third, 3.0f, -1.0f);
    float a[VALUES], b[VALUES], c[VALUES], out[VALUES];
    int s, l;
    (void)state;
    assert_true(rounded != fused);
    for (l = 0; l < VALUES; l++) {
        a[l] = third;
        b[l] = 3.0f;
        c[l] = -1.0f;
    }
    for (s = 0; s < SET_COUNT; s++) {
        if (!can_run(&sets[s])) continue;
        sets[s].muladd(a, b, c, out);
        for (l = 0; l < sets[s].lanes; l++) assert_true(out[l] == (sets[s].fused ? fused : rounded));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_set_computes_what_c_says),
        cmocka_unit_test(vectors_of_three_are_packed_lane_by_lane),
        cmocka_unit_test(shorts_places_bits_and_equal_ints_are_those_of_each_lane),
        cmocka_unit_test(bytes_halves_fours_and_turned_squares_come_in_their_order),
        cmocka_unit_test(what_is_not_a_number_loses_every_comparison),
        cmocka_unit_test(bits_of_a_mask_are_those_of_its_lanes),
        cmocka_unit_test(whole_numbers_are_those_of_c_and_wrap),
        cmocka_unit_test(lanes_of_a_mask_are_appended_in_their_order),
        cmocka_unit_test(bits_are_counted_and_found_and_half_words_too),
        cmocka_unit_test(vectors_come_out_as_they_went_in),
        cmocka_unit_test(muladd_rounds_once_in_avx_and_twice_elsewhere)
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#include "src/shared/fp_end.h"
