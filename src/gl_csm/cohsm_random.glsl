// cohsm_random - makes random numbers with the answers of lightsampling.h, counter-based and the same on all
// machines. They are those of src/shared: rng.h and lds.h. It needs nothing.

// Returns a hash.
uint cohsm_hash(uint x)
{
    uint state = x * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

// Returns a hash of two numbers.
uint cohsm_hash_combine(uint a, uint b) { return cohsm_hash(a + 0x9e3779b9u * cohsm_hash(b)); }

// Returns the highest 24 bits as a number in [0, 1).
float cohsm_to_unit(uint bits) { return float(bits >> 8) * (1.0 / 16777216.0); }

// Returns number i of a stream, in [0, 1).
float cohsm_random(uint seed, uint stream, uint i)
{
    return cohsm_to_unit(cohsm_hash_combine(cohsm_hash_combine(seed, stream), i));
}

// Returns the bits of x in the opposite order.
uint cohsm_reverse_bits(uint x)
{
    x = (x >> 16) | (x << 16);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}

// Returns x with its bits scrambled as Owen does, by a hash (Laine and Karras, constants of Burley 2020).
uint cohsm_owen(uint x, uint seed)
{
    x = cohsm_reverse_bits(x) + seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return cohsm_reverse_bits(x);
}

// Returns point i of a scrambled (0, 2)-sequence.
vec2 cohsm_sobol2(uint i, uint seed)
{
    uint y = 0u, d = 0x80000000u;
    i = cohsm_owen(i, cohsm_hash(seed));
    uint x = cohsm_reverse_bits(i);
    for (uint k = i; k != 0u; k >>= 1) {
        if ((k & 1u) != 0u) y ^= d;
        d ^= d >> 1;
    }
    return vec2(cohsm_to_unit(cohsm_owen(x, cohsm_hash_combine(seed, 1u))),
                cohsm_to_unit(cohsm_owen(y, cohsm_hash_combine(seed, 2u))));
}
