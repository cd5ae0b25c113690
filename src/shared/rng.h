/* unit rng: hashes and random numbers, the same on every machine */

/* Returns a hash by the output function of O'Neill's PCG: Jarzynski and Olano, "Hash functions for GPU
   rendering", JCGT 9(3), 2020. */
static inline uint32_t P_hash32(uint32_t x)
{
    uint32_t state = x * 747796405u + 2891336453u;
    uint32_t word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

static inline uint32_t P_hash_combine(uint32_t a, uint32_t b)
{
    return P_hash32(a + 0x9e3779b9u * P_hash32(b));
}

/* Returns the upper 24 bits as a number in [0, 1). Every such value is a float; the largest is 1 - 2^-24. */
static inline float P_to_unit(uint32_t bits) { return (float)(bits >> 8) * (1.0f / 16777216.0f); }

/* Returns number i, in [0, 1), of the stream (seed, stream). There is no state, so that threads and tiles
   can draw their own numbers. */
static inline float P_random(uint32_t seed, uint32_t stream, uint32_t i)
{
    return P_to_unit(P_hash_combine(P_hash_combine(seed, stream), i));
}

typedef struct P_rng { uint64_t state; } P_rng;

static inline uint32_t P_rng_u32(P_rng *r)
{
    uint64_t old = r->state;
    uint32_t x = (uint32_t)((old >> 18 ^ old) >> 27 & 0xffffffffu), rot = (uint32_t)(old >> 59);
    r->state = old * 6364136223846793005u + 1442695040888963407u;
    return x >> rot | x << ((32u - rot) & 31u);
}

static inline P_rng P_rng_make(uint32_t seed)
{
    P_rng r;
    r.state = (uint64_t)P_hash32(seed) << 32 | P_hash32(~seed);
    P_rng_u32(&r);
    return r;
}

static inline float P_rng_float(P_rng *r) { return P_to_unit(P_rng_u32(r)); }
