// ism_hash - the hashes and random numbers of ism.h.

uint ism_hash32(uint x)
{
    uint state = x * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

uint ism_hash_combine(uint a, uint b) { return ism_hash32(a + 0x9e3779b9u * ism_hash32(b)); }

// Returns the upper 24 bits as a number in [0, 1).
float ism_to_unit(uint bits) { return float(bits >> 8) * (1.0 / 16777216.0); }
