/* bytes - hashes of what the shared units compute: the same on every compiler, option and byte order. */

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/shared/fp_begin.h"
#include "src/shared/v3.h"
#include "src/shared/m4.h"
#include "src/shared/trig.h"
#include "src/shared/bytes.h"
#include "src/shared/crc.h"
#include "src/shared/rng.h"
#include "src/shared/lds.h"
#include "src/shared/octa.h"
#include "src/shared/cdf.h"

/* The lanes of what the program is compiled for. */
#define P_FILE "simd_kernels.h"
#include "src/shared/cpu.h"
#include "src/shared/bits.h"
#include "src/shared/simd.h"
#define P_SET plain
#define P_WIDTH P_SIMD_WIDTH
#define P_LANE_COUNT 8
#include "simd_kernels.h"
#undef simd_compute

#define COUNT 100000u

static uint32_t hash_float(uint32_t crc, float value)
{
    uint8_t bytes[4];
    P_put_f32(bytes, value);
    return P_crc32(crc, bytes, 4);
}

static uint32_t hash_v3(uint32_t crc, P_v3 v)
{
    return hash_float(hash_float(hash_float(crc, v.x), v.y), v.z);
}

static float signed_random(uint32_t stream, uint32_t i, float size)
{
    return (2.0f * P_random(7, stream, i) - 1.0f) * size;
}

/* No denormal results: a program linked with -ffast-math flushes them to 0 at run time. */
static void trigonometry(void)
{
    uint32_t sines = 0, arcs = 0, tans = 0, exps = 0, logs = 0, pows = 0, i;
    for (i = 0; i < COUNT; i++) {
        float s, c, x = signed_random(1, i, 1.0f), y = signed_random(2, i, 1.0f);
        P_sincos(x * 4000.0f, &s, &c);
        sines = hash_float(hash_float(sines, s), c);
        arcs = hash_float(hash_float(arcs, P_acos(x)), P_asin(y));
        tans = hash_float(tans, P_atan2(y, x));
        exps = hash_float(exps, P_exp(x * 80.0f));
        logs = hash_float(logs, P_log(fabsf(y) * 1000.0f));
        pows = hash_float(pows, P_pow(0.001f + fabsf(x), y * 10.0f));
    }
    printf("sincos %08lx\nasin acos %08lx\n", (unsigned long)sines, (unsigned long)arcs);
    printf("atan2 %08lx\n", (unsigned long)tans);
    printf("exp %08lx\nlog %08lx\npow %08lx\n", (unsigned long)exps, (unsigned long)logs, (unsigned long)pows);
}

static void vectors(void)
{
    uint32_t directions = 0, squares = 0, points = 0, i;
    for (i = 0; i < COUNT; i++) {
        float u, v, m[16], inverse[16];
        P_v3 n, b, c, p = P_v3_make(signed_random(3, i, 5.0f), signed_random(4, i, 5.0f), signed_random(5, i, 5.0f));
        n = P_v3_normalize(p);
        P_octa_square(n, &u, &v);
        squares = hash_float(hash_float(squares, u), v);
        n = P_octa_direction(u, v);
        P_v3_basis(n, &b, &c);
        directions = hash_v3(hash_v3(hash_v3(directions, n), b), P_v3_cross(b, p));
        memset(m, 0, sizeof m);
        P_v3_store(m, b);
        P_v3_store(m + 4, P_v3_scale(c, 1.5f));
        P_v3_store(m + 8, P_v3_add(n, b));
        P_v3_store(m + 12, p);
        m[15] = 1.0f;
        if (P_m4_affine_inverse(inverse, m)) points = hash_v3(points, P_m4_point(inverse, n));
    }
    printf("octa %08lx %08lx\nm4 %08lx\n", (unsigned long)squares, (unsigned long)directions, (unsigned long)points);
}

static void distributions(void)
{
    static float weights[1000];
    static double sums[1001];
    uint32_t samples = 0, sequences = 0, i;
    P_cdf cdf;
    for (i = 0; i < 1000; i++) weights[i] = i % 9 == 0 ? 0.0f : P_random(7, 6, i);
    P_cdf_build(&cdf, sums, weights, 1000, 0.3);
    for (i = 0; i < COUNT; i++) {
        float u, v;
        P_cdf_sample s;
        P_sobol2(i, 5, &u, &v);
        s = P_cdf_sample_at(&cdf, u);
        samples = hash_float(hash_float(samples, (float)s.index + s.fraction), s.probability);
        sequences = hash_float(hash_float(sequences, v), P_radical3(i));
    }
    printf("cdf %08lx\nsequences %08lx\n", (unsigned long)samples, (unsigned long)sequences);
}

static void lanes(void)
{
    float a[8], b[8], out[8 * SIMD_PLANE_COUNT];
    int32_t whole[8], other[8], integers[8 * SIMD_INTS_COUNT];
    uint32_t hash = 0, bits = 0, i, k;
    for (i = 0; i < 1000; i++) {
        for (k = 0; k < 8; k++) {
            a[k] = signed_random(8, 8 * i + k, 1000.0f);
            b[k] = k % 4 ? signed_random(9, 8 * i + k, 2.0f) : a[k];
        }
        simd_compute_plain(a, b, out);
        bits = 31u * bits + simd_bits_plain(a, b);
        for (k = 0; k < 8 * SIMD_PLANE_COUNT; k++) hash = hash_float(hash, out[k]);
        for (k = 0; k < 8; k++) {
            whole[k] = (int32_t)a[k];
            other[k] = 100 * (int32_t)k - 350;
        }
        simd_integers_plain(whole, other, integers);
        for (k = 0; k < 8 * SIMD_INTS_COUNT; k++) bits = 31u * bits + (uint32_t)integers[k];
        bits = 31u * bits + simd_append_plain(a, b, out, integers);
        simd_muladd_plain(a, b, b, out);
        for (k = 0; k < 8; k++) hash = hash_float(hash, out[k]);
    }
    printf("lanes %08lx %08lx\n", (unsigned long)hash, (unsigned long)bits);
}

int main(void)
{
    lanes();
    trigonometry();
    vectors();
    distributions();
    return 0;
}
#include "src/shared/fp_end.h"
