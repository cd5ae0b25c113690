/* ---- queries: a field at points ---- */

/* Interpolates harmonics at lane l of a place: n floats, of each channel in turn. */
static void sfield__fetch_lane(const sfield_field *f, const sfield__place *at, int l, float time, uint32_t n,
                          float *out, int simd)
{
    uint32_t before, after, k;
    float t = sfield__frames_at(f, time, &before, &after), next[3 * SFIELD_MAX_COEFS + 8];
    sfield__between b = sfield__find_between(at, l, 1 - t);
    b = sfield__between_of_frame(f, &b, before);
    sfield__mix_samples(f, &b, n, out, simd);
    if (t <= 0) return;
    b = sfield__find_between(at, l, t);
    b = sfield__between_of_frame(f, &b, after);
    sfield__mix_samples(f, &b, n, next, simd);
    for (k = 0; k < n; k++) out[k] += next[k];
}

static void sfield__query_sh(const sfield_field *f, const sfield__place *at, int l, float time, float *out)
{
    float v[3 * SFIELD_MAX_COEFS + 8];
    uint32_t k, c, n = f->h.bands * f->h.bands;
    sfield__fetch_lane(f, at, l, time, f->h.stride, v, 0);
    for (c = 0; c < f->h.channels; c++)
        for (k = 0; k < n; k++) {
            float x = v[c * f->planes + k];
            out[c * n + k] =
                f->h.kind == SFIELD__KIND_SOURCE || f->h.logarithm ? x : (k ? 0 : 1 / sfield__y00) - x;
        }
}

/* Turns 16 positions in a field's space into planes about its center, in r. Positions that are not finite go
   to the center; the bits returned are those of the others. */
static uint32_t sfield__gather_positions(const sfield_field *f, const float *positions, size_t count,
                                         float *p)
{
    uint32_t good = 0, l, k;
    for (l = 0; l < SFIELD__LANES; l++) {
        const float *q = positions + 3 * (l < count ? l : 0);
        float d[3], size = 0;
        for (k = 0; k < 3; k++) {
            d[k] = (q[k] - f->h.center[k]) / f->h.radius;
            size += fabsf(d[k]);
        }
        if (sfield__finite(size) && size < 1e15f) good |= 1u << l;
        for (k = 0; k < 3; k++) p[k * SFIELD__LANES + l] = good >> l & 1 ? d[k] : 0;
    }
    return good;
}

/* Checks what the queries of this name are given. occlusion: not 0 if only visibility will do. */
static sfield_result sfield__check_query(const sfield_field *f, const char *function, const float *positions,
                                         const float *out, int occlusion)
{
    const sfield__logger log = sfield__logger_for(&f->log, function);
    if (!positions || !out) return sfield__fail_null(&log, positions ? "out" : "positions");
    if (f->h.kind == SFIELD__KIND_SELF)
        return sfield__fail(&log, SFIELD_ERR_MISMATCH, "field", "is a self-visibility");
    if (occlusion && f->h.kind != SFIELD__KIND_OCCLUSION)
        return sfield__fail(&log, SFIELD_ERR_MISMATCH, "field", "is a source, not an occlusion field");
    if (occlusion && f->h.logarithm)
        return sfield__fail(&log, SFIELD_ERR_MISMATCH, "field", "holds logarithms");
    if (f->h.shard_end)
        return sfield__fail(&log, SFIELD_ERR_MISMATCH, "field", "is a shard: sfield_merge first");
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_query(const sfield_field *f, size_t count, const float *positions, float time,
                                      float *out)
{
    float p[3 * SFIELD__LANES];
    sfield__place at;
    size_t i, size;
    uint32_t l, good, haar, n;
    sfield_result result;
    if (!f) return SFIELD_ERR_ARGUMENT;
    result = sfield__check_query(f, "sfield_query", positions, out, 0);
    if (result != SFIELD_OK) return result;
    haar = f->h.basis == SFIELD_BASIS_HAAR;
    size = (size_t)f->h.channels * (haar ? 6 * f->h.cube_side * f->h.cube_side : f->h.bands * f->h.bands);
    for (i = 0; i < count; i += SFIELD__LANES) {
        n = count - i < SFIELD__LANES ? (uint32_t)(count - i) : (uint32_t)SFIELD__LANES;
        good = sfield__gather_positions(f, positions + 3 * i, n, p);
        sfield__locate16(f, p, &at, 0);
        for (l = 0; l < n; l++) {
            float *o = out + (i + l) * size;
            size_t k;
            if (!(good >> l & 1)) {
                for (k = 0; k < size; k++) o[k] = haar && f->h.kind != SFIELD__KIND_SOURCE ? 1.0f : 0.0f;
                if (!haar && f->h.kind != SFIELD__KIND_SOURCE && !f->h.logarithm) o[0] = 1 / sfield__y00;
            }
#ifndef SFIELD_WITHOUT_WAVELETS
            else if (haar) sfield__query_haar(f, &at, (int)l, time, o);
#endif
            else sfield__query_sh(f, &at, (int)l, time, o);
        }
    }
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_ambient(const sfield_field *f, size_t count, const float *positions,
                                        float *out)
{
    float p[3 * SFIELD__LANES], first[16];
    sfield__place at;
    uint32_t l, n, good;
    size_t i;
    sfield_result result;
    if (!f) return SFIELD_ERR_ARGUMENT;
    result = sfield__check_query(f, "sfield_ambient", positions, out, 1);
    if (result != SFIELD_OK) return result;
    for (i = 0; i < count; i += n) {
        n = count - i < SFIELD__LANES ? (uint32_t)(count - i) : (uint32_t)SFIELD__LANES;
        good = sfield__gather_positions(f, positions + 3 * i, n, p);
        sfield__locate16(f, p, &at, 0);
        for (l = 0; l < n; l++) {
            float hidden = 0;
            if (f->h.basis == SFIELD_BASIS_SH) {
                sfield__fetch_lane(f, &at, (int)l, 0, 8, first, 0);
                hidden = first[0] * sfield__y00;
            }
#ifndef SFIELD_WITHOUT_WAVELETS
            else hidden = sfield__hidden_share(f, &at, (int)l);
#endif
            out[i + l] = good >> l & 1 ? (hidden < 1 ? (hidden > 0 ? 1 - hidden : 1.0f) : 0.0f) : 1.0f;
        }
    }
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_self(const sfield_field *f, size_t first, size_t count, float *out)
{
    uint32_t k, n;
    size_t i;
    sfield__logger log;
    if (!f) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_for(&f->log, "sfield_self");
    if (!out) return sfield__fail_null(&log, "out");
    if (f->h.kind != SFIELD__KIND_SELF)
        return sfield__fail(&log, SFIELD_ERR_MISMATCH, "field", "is not a self-visibility");
    if (!sfield__check_value(&log, first <= f->h.samples, "first", (double)first,
                             "at most the field's points") ||
        !sfield__check_value(&log, count <= f->h.samples - first, "count", (double)count,
                             "at most the field's points from `first` on"))
        return SFIELD_ERR_ARGUMENT;
    n = f->h.basis == SFIELD_BASIS_SH ? f->h.bands * f->h.bands : 6 * f->h.cube_side * f->h.cube_side;
    for (i = 0; i < count; i++) {
        float *o = out + i * n;
        if (f->h.basis == SFIELD_BASIS_SH) {
            for (k = 0; k < n; k++)
                o[k] = f->scale[k] * (float)f->sample[(first + i) * f->h.stride + k] + f->bias[k];
        }
#ifndef SFIELD_WITHOUT_WAVELETS
        else sfield__self_haar(f, first + i, o);
#endif
    }
    return SFIELD_OK;
}
