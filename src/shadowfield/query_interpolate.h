/* ---- queries: the eight samples about a point, interpolated ---- */

/* Writes out[k], the sum over eight samples, for k < n, a multiple of 8. Kernels work on sixteen values at
   a time: up to eight floats behind out[n - 1] are written, too. */
static void sfield__mix_samples(const sfield_field *f, const sfield__between *at, uint32_t n, float *out,
                                int simd);

/* Transposes n columns, a multiple of 8, of 16 rows that are `stride` floats apart, to n planes of 16. */
static void sfield__rows_to_planes(const float *rows, size_t stride, uint32_t n, float *planes, int simd);

/* Neighbours mostly lie between the same eight samples. The bytes of those are made floats once, and all
   lanes use them, with weights of 0 where they do not belong. Each lane gets the same bits as by
   sfield__mix_samples. */
typedef struct sfield__eight {
    uint32_t     n;                             /* coefficients, a multiple of 8 */
    const float *s0, *b0, *s1, *b1;             /* scale and bias of both shells */
    float        q[8 * SFIELD_MAX_COEFS + 8];   /* of eight samples, corners of the inner shell first */
} sfield__eight;

/* Writes n bytes of each of the eight samples about a place as floats, sample after sample. */
static void sfield__widen_samples(const sfield_field *f, const uint8_t *first, uint32_t n, float *out,
                                  int simd);

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
    const size_t stride = f->h.stride;
    c->n = n;
    c->s0 = f->scale + group * stride + from;
    c->b0 = f->bias + group * stride + from;
    c->s1 = c->s0 + stride;
    c->b1 = c->b0 + stride;
    sfield__widen_samples(f, f->sample + base * stride + from, n, c->q, simd);
}
