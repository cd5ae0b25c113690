/* ---- accumulate: sums over samples and frames ---- */

LSAMP_DEF lsamp_result lsamp_accumulate(size_t count, uint32_t sample_count, const float *weights,
                                        const float *visibility, float *radiance, size_t radiance_stride)
{
    size_t i, c, at = 0;
    uint32_t k;

    if (sample_count == 0 || (count && (!weights || !radiance)) || !lsamp__stride_valid(radiance_stride, 12))
        return LSAMP_ERR_ARGUMENT;
    for (i = 0; i < count; i++) {
        float *out = (float *)(void *)((char *)radiance + (radiance_stride ? radiance_stride : 12u) * i);
        double sum[3] = { 0.0, 0.0, 0.0 };

        for (k = 0; k < sample_count; k++, at++) {
            const float *w = weights + at * 3u;
            double v;
            if (w[0] == 0.0f && w[1] == 0.0f && w[2] == 0.0f) continue;
            v = visibility ? (double)visibility[at] : 1.0;
            if (!(v > 0.0)) continue;       /* also of COHSM_REFUSED */
            for (c = 0; c < 3; c++) sum[c] += v * (double)w[c];
        }
        for (c = 0; c < 3; c++) out[c] += (float)sum[c];
    }
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_progressive_reset(lsamp_progressive *p)
{
    size_t i;
    if (!p || (p->count && !p->sums)) return LSAMP_ERR_ARGUMENT;
    for (i = 0; i < p->count; i++) p->sums[i] = 0.0;
    p->frame_count = 0;
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_progressive_add(lsamp_progressive *p, const float *frame)
{
    size_t i;
    if (!p || (p->count && (!p->sums || !frame))) return LSAMP_ERR_ARGUMENT;
    if (p->frame_count == UINT32_MAX) return LSAMP_ERR_LIMIT;
    for (i = 0; i < p->count; i++) p->sums[i] += (double)frame[i];
    p->frame_count++;
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_progressive_mean(const lsamp_progressive *p, float *mean)
{
    size_t i;
    if (!p || (p->count && (!p->sums || !mean))) return LSAMP_ERR_ARGUMENT;
    if (p->frame_count == 0) return LSAMP_ERR_ORDER;
    for (i = 0; i < p->count; i++) mean[i] = (float)(p->sums[i] / (double)p->frame_count);
    return LSAMP_OK;
}
