// rsm_pick - picks texels of a map in proportion to their flux, by running sums.
// uses: rsm_access rsm_bound

// Hashes and random numbers are rsm.h's, bit by bit.
uint rsm_hash32(uint x)
{
    uint state = x * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

uint rsm_hash_combine(uint a, uint b) { return rsm_hash32(a + 0x9e3779b9u * rsm_hash32(b)); }
float rsm_to_unit(uint bits) { return float(bits >> 8) * (1.0 / 16777216.0); }
float rsm_random(uint seed, uint stream, uint i)
{
    return rsm_to_unit(rsm_hash_combine(rsm_hash_combine(seed, stream), i));
}

// Returns the flux of all faces of a map.
float rsm_total(rsm_light l)
{
    float total = 0.0;
    for (int f = 0; f < l.faces; f++) total += RSM_ROWS_SUM(int(l.side) - 1, f);
    return total;
}

// Picks texel and weight of sample i of n, by a lattice that the seed shifts: rows at even steps of flux,
// places in a row by the golden ratio. Returns false if there is no light.
bool rsm_pick_texel(rsm_light l, uint i, uint n, uint seed, out ivec3 t, out float weight)
{
    float total = rsm_total(l), u = fract(rsm_to_unit(i * 2654435769u) + rsm_random(seed, 5u, 0u));
    float x = min((float(i) + rsm_random(seed, 6u, 0u)) / float(n), 0.99999994) * total;
    int size = int(l.side), low = 0, high = size - 1;
    t = ivec3(0);
    weight = 0.0;
    if (!(total > 0.0)) return false;
    for (int f = 0; f + 1 < l.faces; f++) {
        float sum = RSM_ROWS_SUM(size - 1, f);
        if (t.z != f || x < sum) continue;
        x -= sum;
        t.z = f + 1;
    }
    while (low < high) {                    // finds the first row whose sum exceeds x
        int middle = (low + high) / 2;
        if (RSM_ROWS_SUM(middle, t.z) > x) high = middle;
        else low = middle + 1;
    }
    t.y = low;
    x = min(u, 0.99999994) * RSM_ROW_SUM(ivec3(size - 1, t.yz));
    low = 0;
    high = size - 1;
    while (low < high) {                    // finds the first texel
        int middle = (low + high) / 2;
        if (RSM_ROW_SUM(ivec3(middle, t.yz)) > x) high = middle;
        else low = middle + 1;
    }
    t.x = low;
    float flux = rsm_mean3(uintBitsToFloat(RSM_TEXEL(t, 2).xyz));
    if (!(flux > 0.0)) return false;
    weight = total / (float(n) * flux);
    return true;
}
