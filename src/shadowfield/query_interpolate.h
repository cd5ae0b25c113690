/* ---- queries: the eight samples about a point, interpolated ---- */

/* Writes out[k], the sum over eight samples, for k < n, a multiple of 8. */
static void sfield__mix_samples_plain(const sfield_field *f, const sfield__between *at, uint32_t n,
                                      float *out)
{
    const float *b = at->corner, w0 = at->inner, w1 = at->outer;
    const size_t stride = f->h.stride, row = f->h.position_side * stride,
                 shell = 6 * f->h.position_side * row;
    const uint8_t *q = f->sample + at->base * stride;
    const float *s0 = f->scale + at->group * stride, *b0 = f->bias + at->group * stride;
    uint32_t k, l;
    for (k = 0; k < n; k += 8, q += 8)
        for (l = 0; l < 8; l++) {
            float a = (float)q[l] * b[0] + (float)q[stride + l] * b[1] + (float)q[row + l] * b[2] +
                      (float)q[row + stride + l] * b[3];
            float c = (float)q[shell + l] * b[0] + (float)q[shell + stride + l] * b[1] +
                      (float)q[shell + row + l] * b[2] + (float)q[shell + row + stride + l] * b[3];
            out[k + l] =
                w0 * (a * s0[k + l] + b0[k + l]) + w1 * (c * s0[stride + k + l] + b0[stride + k + l]);
        }
}

#if SFIELD__SIMD
SFIELD__TARGET_AVX2 SFIELD__INLINE __m256 sfield__bytes8(const uint8_t *q)
{
    return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)(const void *)q)));
}

SFIELD__TARGET_AVX2 static void sfield__mix_samples_avx2(const sfield_field *f, const sfield__between *at,
                                                         uint32_t n, float *out)
{
    const float *b = at->corner, w0 = at->inner, w1 = at->outer;
    const size_t stride = f->h.stride, row = f->h.position_side * stride,
                 shell = 6 * f->h.position_side * row;
    const uint8_t *q = f->sample + at->base * stride;
    const float *s0 = f->scale + at->group * stride, *b0 = f->bias + at->group * stride;
    const __m256 x0 = _mm256_set1_ps(b[0]), x1 = _mm256_set1_ps(b[1]), x2 = _mm256_set1_ps(b[2]),
                 x3 = _mm256_set1_ps(b[3]);
    uint32_t k;
    for (k = 0; k < n; k += 8, q += 8) {
        __m256 a = _mm256_mul_ps(sfield__bytes8(q), x0), c = _mm256_mul_ps(sfield__bytes8(q + shell), x0);
        a = _mm256_fmadd_ps(sfield__bytes8(q + stride), x1, a);
        c = _mm256_fmadd_ps(sfield__bytes8(q + shell + stride), x1, c);
        a = _mm256_fmadd_ps(sfield__bytes8(q + row), x2, a);
        c = _mm256_fmadd_ps(sfield__bytes8(q + shell + row), x2, c);
        a = _mm256_fmadd_ps(sfield__bytes8(q + row + stride), x3, a);
        c = _mm256_fmadd_ps(sfield__bytes8(q + shell + row + stride), x3, c);
        a = _mm256_fmadd_ps(a, _mm256_loadu_ps(s0 + k), _mm256_loadu_ps(b0 + k));
        c = _mm256_fmadd_ps(c, _mm256_loadu_ps(s0 + stride + k), _mm256_loadu_ps(b0 + stride + k));
        a = _mm256_mul_ps(a, _mm256_set1_ps(w0));
        _mm256_storeu_ps(out + k, _mm256_fmadd_ps(c, _mm256_set1_ps(w1), a));
    }
}

SFIELD__TARGET_AVX2 static void sfield__transpose8_avx2(const float *in, size_t in_stride, float *out,
                                                   size_t out_stride)
{
    __m256 r[8], t[8];
    size_t i;
    for (i = 0; i < 8; i++) r[i] = _mm256_loadu_ps(in + i * in_stride);
    for (i = 0; i < 4; i++) {
        t[2 * i] = _mm256_unpacklo_ps(r[2 * i], r[2 * i + 1]);
        t[2 * i + 1] = _mm256_unpackhi_ps(r[2 * i], r[2 * i + 1]);
    }
    for (i = 0; i < 2; i++) {
        r[4 * i] = _mm256_shuffle_ps(t[4 * i], t[4 * i + 2], 0x44);
        r[4 * i + 1] = _mm256_shuffle_ps(t[4 * i], t[4 * i + 2], 0xee);
        r[4 * i + 2] = _mm256_shuffle_ps(t[4 * i + 1], t[4 * i + 3], 0x44);
        r[4 * i + 3] = _mm256_shuffle_ps(t[4 * i + 1], t[4 * i + 3], 0xee);
    }
    for (i = 0; i < 4; i++) {
        _mm256_storeu_ps(out + out_stride * i, _mm256_permute2f128_ps(r[i], r[4 + i], 0x20));
        _mm256_storeu_ps(out + out_stride * (i + 4), _mm256_permute2f128_ps(r[i], r[4 + i], 0x31));
    }
}
#endif

static void sfield__mix_samples(const sfield_field *f, const sfield__between *at, uint32_t n, float *out,
                                int simd)
{
#if SFIELD__SIMD
    if (simd) {
        sfield__mix_samples_avx2(f, at, n, out);
        return;
    }
#endif
    (void)simd;
    sfield__mix_samples_plain(f, at, n, out);
}

/* Transposes 16 vectors of n floats, a multiple of 8, to n planes of 16. */
static void sfield__transpose16(const float *in, uint32_t n, float *out, int simd)
{
    uint32_t k, l;
#if SFIELD__SIMD
    if (simd) {
        for (k = 0; k < n; k += 8)
            for (l = 0; l < SFIELD__LANES; l += 8)
                sfield__transpose8_avx2(in + k + l * n, n, out + k * SFIELD__LANES + l, SFIELD__LANES);
        return;
    }
#endif
    (void)simd;
    for (k = 0; k < n; k++)
        for (l = 0; l < SFIELD__LANES; l++) out[k * SFIELD__LANES + l] = in[l * n + k];
}

/* Neighbours mostly lie between the same eight samples. Those are made floats once, and go on all lanes, by
   weights of 0 where they do not belong: each value gets the roundings that its lane by itself gets of
   mix. */
typedef struct sfield__eight {
    uint32_t     n;                             /* coefficients, a multiple of 8 */
    const float *s0, *b0, *s1, *b1;             /* scale and bias of both shells */
    float        q[8 * SFIELD_MAX_COEFS];       /* of eight samples, corners of the inner shell first */
} sfield__eight;

#if SFIELD__SIMD
SFIELD__TARGET_AVX2 static void sfield__eight_bytes_avx2(const uint8_t *sample, size_t stride, size_t row,
                                                         size_t shell, uint32_t n, float *q)
{
    uint32_t k;
    for (k = 0; k < n; k += 8, sample += 8, q += 8) {
        _mm256_storeu_ps(q, sfield__bytes8(sample));
        _mm256_storeu_ps(q + n, sfield__bytes8(sample + stride));
        _mm256_storeu_ps(q + 2 * n, sfield__bytes8(sample + row));
        _mm256_storeu_ps(q + 3 * n, sfield__bytes8(sample + row + stride));
        _mm256_storeu_ps(q + 4 * n, sfield__bytes8(sample + shell));
        _mm256_storeu_ps(q + 5 * n, sfield__bytes8(sample + shell + stride));
        _mm256_storeu_ps(q + 6 * n, sfield__bytes8(sample + shell + row));
        _mm256_storeu_ps(q + 7 * n, sfield__bytes8(sample + shell + row + stride));
    }
}
#endif
/* Groups lanes by the eight samples that they lie between. Returns how many groups there are, or 0 if lane by
   lane costs less. */
static uint32_t sfield__group_lanes(const sfield__place *at, uint32_t lanes, uint32_t *group, int simd)
{
    const uint32_t most = sfield__popcount(lanes) / SFIELD__SHARED;
    uint32_t count = 0;
    for (; lanes && count < most; lanes &= ~group[count++]) {
        uint32_t first = 0;
        while (!(lanes >> first & 1)) first++;
        group[count] = sfield__same16(at->base, at->base[first], simd) & lanes;
    }
    return lanes ? 0 : count;
}

/* Loads n coefficients, from one on, of the eight samples whose first sample and group are given. */
static void sfield__load_eight(const sfield_field *f, size_t base, size_t group, uint32_t from, uint32_t n,
                               sfield__eight *c, int simd)
{
    const size_t stride = f->h.stride, row = f->h.position_side * stride,
                 shell = 6 * f->h.position_side * row;
    const uint8_t *q = f->sample + base * stride + from;
    uint32_t i, k;
    c->n = n;
    c->s0 = f->scale + group * stride + from;
    c->b0 = f->bias + group * stride + from;
    c->s1 = c->s0 + stride;
    c->b1 = c->b0 + stride;
#if SFIELD__SIMD
    if (simd) {
        sfield__eight_bytes_avx2(q, stride, row, shell, n, c->q);
        return;
    }
#endif
    (void)simd;
    for (i = 0; i < 8; i++)
        for (k = 0; k < n; k++)
            c->q[i * n + k] = (float)q[(i & 1) * stride + (i >> 1 & 1) * row + (i >> 2) * shell + k];
}
