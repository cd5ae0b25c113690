/* ---- jitter ---- */

ENVLT_DEF envlt_result envlt_jitter(const envlt_lights *l, uint32_t frame, uint32_t seed, envlt_light *out)
{
    uint32_t i;
    envlt__logger logger;
    if (!l) return ENVLT_ERR_ARGUMENT;
    logger = envlt__make_logger(&l->desc.system, "envlt_jitter");
    if (!out && l->count) return envlt__refuse_text(&logger, "out", "is NULL", ENVLT_ERR_ARGUMENT);
    for (i = 0; i < l->count; i++) {
        uint32_t hash = envlt__hash_combine(seed, l->list[i].id), t, row, column;
        uint32_t first = l->start[i], a, b;
        envlt__cdf cdf;
        envlt__cdf_sample s;
        double d[3], length;
        out[i] = l->list[i];
        if (first == l->start[i + 1]) continue;         /* the sun has taken all texels of this stratum */
        /* Points of the R2 sequence, shifted by a hash of the light. The first coordinate chooses the texel,
           and what is left of it says how far across the texel; the second says how far down. */
        a = 0x80000000u + frame * 3242174889u + hash;
        b = 0x80000000u + frame * 2447445413u + envlt__hash32(hash);
        cdf.sums = l->cdf + first + i;
        cdf.count = l->start[i + 1] - first;
        s = envlt__cdf_sample_at(&cdf, envlt__to_unit(a));
        t = l->order[first + s.index];
        row = t / l->map.width;
        column = (uint32_t)(((uint64_t)t % l->map.width + l->roll) % l->map.width);
        envlt__direction(&l->map, row / l->map.height, (double)column + (double)s.fraction,
                         (double)(row % l->map.height) + (double)envlt__to_unit(b), d);
        length = 1.0 / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        for (row = 0; row < 3; row++) out[i].direction[row] = (float)(d[row] * length);
    }
    return ENVLT_OK;
}
