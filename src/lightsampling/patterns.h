/* ---- patterns: the random numbers of samples ---- */

LSAMP_DEF size_t lsamp_patterns_bytes(uint32_t length)
{
    if (length == 0 || length > 65536u) return 0;
    return (size_t)LSAMP_PATTERN_COUNT * length * 2u * sizeof(float);
}

/* The points are Hammersley points, of which one axis is jittered inside the columns and the other is
   Owen-scrambled. They are computed in integers of 24 bits, so that no rounding takes a point across the edge
   of its column. */
LSAMP_DEF lsamp_result lsamp_patterns_build(uint32_t length, uint32_t seed, float *patterns, size_t bytes)
{
    size_t need = lsamp_patterns_bytes(length);
    uint32_t j, k;

    if (!patterns || !need) return LSAMP_ERR_ARGUMENT;
    if (bytes < need) return LSAMP_ERR_MEMORY;
    for (j = 0; j < LSAMP_PATTERN_COUNT; j++) {
        uint32_t scramble = lsamp__hash_combine(seed, j);
        for (k = 0; k < length; k++, patterns += 2) {
            uint32_t low = (uint32_t)((((uint64_t)k << 24) + length - 1u) / length);
            uint32_t high = (uint32_t)((((uint64_t)(k + 1u) << 24) + length - 1u) / length);
            uint32_t at = low + (uint32_t)(lsamp__random(seed, ~j, k) * (float)(high - low));
            patterns[0] = (float)(at < high ? at : high - 1u) * (1.0f / 16777216.0f);
            patterns[1] = lsamp__to_unit(lsamp__owen(lsamp__reverse_bits(k), scramble));
        }
    }
    return LSAMP_OK;
}

/* Writes the random numbers of sample k of a pixel, the third one for callbacks only. 159 is odd and close to
   256 / golden ratio, so that the patterns of successive frames are far apart, and all 256 get their turn;
   then they come again with a toroidal shift. */
static void lsamp__random_numbers(const lsamp_sample_desc *d, uint32_t pixel, uint32_t k, int third, float *u)
{
    uint32_t key = lsamp__hash_combine(d->seed, pixel), index = d->frame * d->sample_count + k;

    if (d->patterns) {
        const float *at = d->patterns + ((size_t)((key + d->frame * 159u) & 255u) * d->sample_count + k) * 2u;
        u[0] = at[0];
        u[1] = at[1];
        if (d->frame > 255u) {
            u[0] += lsamp__random(key, d->frame >> 8, 0u);
            u[1] += lsamp__random(key, d->frame >> 8, 1u);
            u[0] = lsamp__clamp_unit(u[0] - floorf(u[0]));
            u[1] = lsamp__clamp_unit(u[1] - floorf(u[1]));
        }
    } else {
        lsamp__sobol2(index, key, &u[0], &u[1]);
    }
    u[2] = third ? lsamp__random(key, 0x9e3779b9u, index) : 0.0f;
}
