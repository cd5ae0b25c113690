/* ref_math.h - vectors and random numbers of the reference path tracer, in double precision.
   The reference shares no code with the Dapple headers, so that a fault in one does not hide in the other. */
#ifndef RF_MATH_H
#define RF_MATH_H

#include <math.h>
#include <stdint.h>

#define RF_PI 3.14159265358979323846

/* As fmin and fmax but for NaN, which never gets here; those are function calls for most compilers. */
static inline double rf_least(double a, double b) { return a < b ? a : b; }
static inline double rf_most(double a, double b) { return a > b ? a : b; }

typedef struct rf_v3 { double x, y, z; } rf_v3;

static inline rf_v3 rf_make(double x, double y, double z) { rf_v3 r = { x, y, z }; return r; }
static inline rf_v3 rf_load(const float *p) { return rf_make((double)p[0], (double)p[1], (double)p[2]); }
static inline rf_v3 rf_add(rf_v3 a, rf_v3 b) { return rf_make(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline rf_v3 rf_sub(rf_v3 a, rf_v3 b) { return rf_make(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline rf_v3 rf_mul(rf_v3 a, rf_v3 b) { return rf_make(a.x * b.x, a.y * b.y, a.z * b.z); }
static inline rf_v3 rf_scale(rf_v3 a, double s) { return rf_make(a.x * s, a.y * s, a.z * s); }
static inline rf_v3 rf_mad(rf_v3 a, rf_v3 b, double s) { return rf_add(a, rf_scale(b, s)); }      /* a + b s */
static inline double rf_dot(rf_v3 a, rf_v3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline double rf_length(rf_v3 a) { return sqrt(rf_dot(a, a)); }
static inline double rf_mean(rf_v3 a) { return (a.x + a.y + a.z) / 3; }
static inline double rf_max(rf_v3 a) { return rf_most(a.x, rf_most(a.y, a.z)); }
static inline int rf_is_black(rf_v3 a) { return !(rf_max(a) > 0); }

static inline rf_v3 rf_cross(rf_v3 a, rf_v3 b)
{
    return rf_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline rf_v3 rf_unit(rf_v3 a)       /* the zero vector stays zero */
{
    double length = rf_length(a);
    return length > 0 ? rf_scale(a, 1 / length) : a;
}

/* Two unit vectors that make a right-handed frame x, y, n. */
static inline void rf_frame(rf_v3 n, rf_v3 *x, rf_v3 *y)
{
    rf_v3 axis = fabs(n.x) < 0.6 ? rf_make(1, 0, 0) : rf_make(0, 1, 0);
    *y = rf_unit(rf_cross(n, axis));
    *x = rf_cross(*y, n);
}

static inline rf_v3 rf_from_frame(rf_v3 x, rf_v3 y, rf_v3 z, rf_v3 a)
{
    return rf_add(rf_add(rf_scale(x, a.x), rf_scale(y, a.y)), rf_scale(z, a.z));
}

/* ---- sampler: the two-dimensional Sobol sequence, scrambled and shuffled anew for every pair of dimensions ----
   Scrambling after Laine and Karras, "Stratified sampling for stochastic transparency" (2011), which Burley,
   "Practical hash-based Owen scrambling" (2020), applies to Sobol points and to their order. */

typedef struct rf_sampler {
    uint32_t seed;             /* of the pixel, frame and batch */
    uint32_t index;            /* of the sample */
    uint32_t pair;             /* dimensions used so far, in pairs */
} rf_sampler;

static inline uint32_t rf_hash(uint32_t x)
{
    x = (x ^ (x >> 16)) * 0x21f0aaadu;
    x = (x ^ (x >> 15)) * 0x735a2d97u;
    return x ^ (x >> 15);
}

static inline uint32_t rf_reverse(uint32_t x)
{
    x = (x >> 16) | (x << 16);
    x = ((x & 0xff00ff00u) >> 8) | ((x & 0x00ff00ffu) << 8);
    x = ((x & 0xf0f0f0f0u) >> 4) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x & 0xccccccccu) >> 2) | ((x & 0x33333333u) << 2);
    return ((x & 0xaaaaaaaau) >> 1) | ((x & 0x55555555u) << 1);
}

/* A nested permutation of bit-reversed x: each bit is flipped by a hash of the bits below it. Every step keeps that
   property: additions, products with odd numbers, and exclusive-or with products with even numbers. */
static inline uint32_t rf_permute(uint32_t x, uint32_t seed)
{
    x += seed;
    x ^= x * 0x5a1c7d36u;
    x *= rf_hash(seed) | 1u;
    x ^= x * 0x9b04f2e4u;
    x += seed >> 3;
    x ^= x * 0x2e6b8ad2u;
    return x;
}

static inline double rf_to_unit(uint32_t x) { return (x + 0.5) * (1.0 / 4294967296.0); }       /* inside (0, 1) */

/* The second Sobol dimension multiplies the digits by Pascal's triangle modulo 2: digit j is the sum of all digits
   whose number contains the bits of j. (The first dimension is the digits themselves.) */
static inline uint32_t rf_pascal(uint32_t x)
{
    x ^= (x >> 1) & 0x55555555u;
    x ^= (x >> 2) & 0x33333333u;
    x ^= (x >> 4) & 0x0f0f0f0fu;
    x ^= (x >> 8) & 0x00ff00ffu;
    return x ^ (x >> 16);
}

static inline void rf_sample_2d(rf_sampler *s, double u[2])
{
    uint32_t seed = rf_hash(s->seed + 0x9e3779b9u * ++s->pair);
    uint32_t index = rf_reverse(rf_permute(rf_reverse(s->index), seed));
    u[0] = rf_to_unit(rf_reverse(rf_permute(index, rf_hash(seed ^ 0x68bc21ebu))));
    u[1] = rf_to_unit(rf_reverse(rf_permute(rf_pascal(index), rf_hash(seed ^ 0x02e5be93u))));
}

#endif
