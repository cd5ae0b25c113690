/* unit hilbert: Hilbert curves in 1 to 3 dimensions */

/* Writes the cell that has this index on the Hilbert curve through a cube of 2^bits cells a side in `dims`
   (1..3) dimensions. Neighbours on the curve share a face. dims * bits is at most 32, index below 2^(dims *
   bits), and each cell[i] below 2^bits. Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707,
   2004: the bits of the index are dealt out to the axes and Gray-decoded; then exchanges and inversions are
   undone from the finest level up. */
static inline void P_hilbert_cell(uint32_t index, uint32_t bits, uint32_t dims, uint32_t *cell)
{
    uint32_t i, b, q, t;

    for (i = 0; i < dims; i++) {
        cell[i] = 0;
        for (b = 0; b < bits; b++) cell[i] |= (index >> (b * dims + (dims - 1u - i)) & 1u) << b;
    }
    t = cell[dims - 1u] >> 1;
    for (i = dims - 1u; i > 0; i--) cell[i] ^= cell[i - 1u];
    cell[0] ^= t;
    for (b = 1; b < bits; b++) {
        q = (1u << b) - 1u;
        for (i = dims; i-- > 0;) {
            t = cell[i] >> b & 1u ? 0u : (cell[0] ^ cell[i]) & q;
            cell[0] ^= cell[i] >> b & 1u ? q : t;
            cell[i] ^= t;
        }
    }
}

/* Returns the index of a cell, by the inverse of P_hilbert_cell. */
static inline uint32_t P_hilbert_index(const uint32_t *cell, uint32_t bits, uint32_t dims)
{
    uint32_t x[3] = { 0, 0, 0 }, index = 0;
    uint32_t i, b, q, t;

    for (i = 0; i < dims; i++) x[i] = cell[i];
    for (b = bits; b-- > 1u;) {
        q = (1u << b) - 1u;
        for (i = 0; i < dims; i++) {
            t = x[i] >> b & 1u ? 0u : (x[0] ^ x[i]) & q;
            x[0] ^= x[i] >> b & 1u ? q : t;
            x[i] ^= t;
        }
    }
    for (i = 1; i < dims; i++) x[i] ^= x[i - 1u];
    for (t = 0, b = bits; b-- > 1u;)
        if (x[dims - 1u] >> b & 1u) t ^= (1u << b) - 1u;
    for (i = 0; i < dims; i++) x[i] ^= t;
    for (i = 0; i < dims; i++)
        for (b = 0; b < bits; b++) index |= (x[i] >> b & 1u) << (b * dims + (dims - 1u - i));
    return index;
}
