/* unit lds, needs rng: low-discrepancy points in [0, 1) */

static inline uint32_t P_reverse_bits(uint32_t x)
{
    x = x >> 16 | x << 16;
    x = (x >> 8 & 0x00ff00ffu) | (x & 0x00ff00ffu) << 8;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    return (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
}

static inline float P_radical2(uint32_t i) { return P_to_unit(P_reverse_bits(i)); }

/* Returns the radical inverse of i in base 3. The digits are turned round as an integer below 3^20, so that
   one rounding happens; i counts modulo 3^20. */
static inline float P_radical3(uint32_t i)
{
    uint32_t r = 0, k;
    for (k = 0; k < 20u; k++, i /= 3u) r = r * 3u + i % 3u;
    return P_to_unit((uint32_t)((double)r * (4294967296.0 / 3486784401.0)));
}

/* Writes point i of Roberts' R2 sequence: the fractions of i / g and i / g^2 with g^3 = g + 1, in 32-bit
   fixed point. */
static inline void P_r2(uint32_t i, float *u, float *v)
{
    *u = P_to_unit(0x80000000u + i * 3242174889u);
    *v = P_to_unit(0x80000000u + i * 2447445413u);
}

/* Returns x after Owen scrambling, by the hash of Laine and Karras as tuned in Burley, "Practical hash-based
   Owen scrambling", JCGT 9(4), 2020. It works on reversed bits: a bit depends on the more significant ones
   alone. */
static inline uint32_t P_owen(uint32_t x, uint32_t seed)
{
    x = P_reverse_bits(x) + seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return P_reverse_bits(x);
}

/* Writes point i of a scrambled (0, 2)-sequence, which has the first two dimensions of Sobol's. The order is
   shuffled, too, so that sequences of different seeds may be combined to more dimensions. */
static inline void P_sobol2(uint32_t i, uint32_t seed, float *u, float *v)
{
    uint32_t x, y = 0, d = 0x80000000u, k;
    i = P_owen(i, P_hash32(seed));
    x = P_reverse_bits(i);
    for (k = i; k; k >>= 1, d ^= d >> 1)
        if (k & 1u) y ^= d;
    *u = P_to_unit(P_owen(x, P_hash_combine(seed, 1u)));
    *v = P_to_unit(P_owen(y, P_hash_combine(seed, 2u)));
}
