/* ---- kernels: rotations of sixteen vectors ---- */

SFIELD__KERNEL static void sfield__rotate(const sfield_rotation *rotation, const float *in, float *out,
                                          size_t stride, int inverse)
{
    const float *block = rotation->block;
    sfield__lanes r[2 * SFIELD_MAX_BANDS];
    uint32_t l, x, y;
    uint32_t n, across, down;
    for (l = 0; l < rotation->bands; l++) {
        n = 2 * l + 1;
        across = inverse ? n : 1;
        down = inverse ? 1 : n;
        for (y = 0; y < n; y++) {
            const float *from = in + (size_t)l * l * stride, *m = block + y * down;
            sfield__lanes sum = sfield__lanes_mul(sfield__lanes_all(m[0]), sfield__lanes_load(from));
            for (x = 1; x < n; x++) {
                const sfield__lanes one = sfield__lanes_load(from + x * stride);
                sum = sfield__lanes_muladd(sfield__lanes_all(m[x * across]), one, sum);
            }
            r[y] = sum;
        }
        for (y = 0; y < n; y++) sfield__lanes_store(out + ((size_t)l * l + y) * stride, r[y]);
        block += n * n;
    }
}

/* Four bands without loops over a row, in bands of 3, 5 and 7 that registers hold. m: a row; s: stride. */
typedef struct sfield__held { sfield__lanes x0, x1, x2, x3, x4, x5, x6; } sfield__held;

static inline SFIELD__IN_KERNEL sfield__lanes sfield__row3(const float *m, uint32_t s, const sfield__held *h)
{
    sfield__lanes sum = sfield__lanes_mul(sfield__lanes_all(m[0]), h->x0);
    sum = sfield__lanes_muladd(sfield__lanes_all(m[s]), h->x1, sum);
    return sfield__lanes_muladd(sfield__lanes_all(m[2 * s]), h->x2, sum);
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__row5(const float *m, uint32_t s, const sfield__held *h)
{
    sfield__lanes sum = sfield__lanes_muladd(sfield__lanes_all(m[3 * s]), h->x3, sfield__row3(m, s, h));
    return sfield__lanes_muladd(sfield__lanes_all(m[4 * s]), h->x4, sum);
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__row7(const float *m, uint32_t s, const sfield__held *h)
{
    sfield__lanes sum = sfield__lanes_muladd(sfield__lanes_all(m[5 * s]), h->x5, sfield__row5(m, s, h));
    return sfield__lanes_muladd(sfield__lanes_all(m[6 * s]), h->x6, sum);
}

SFIELD__KERNEL static void sfield__rotate4(const sfield_rotation *rotation, const float *in, float *out,
                                           size_t stride, int inverse)
{
    const float *m = rotation->block;
    sfield__held h;
    uint32_t y;
    sfield__lanes_store(out, sfield__lanes_mul(sfield__lanes_all(m[0]), sfield__lanes_load(in)));
    h.x0 = sfield__lanes_load(in + stride);
    h.x1 = sfield__lanes_load(in + 2 * stride);
    h.x2 = sfield__lanes_load(in + 3 * stride);
    for (y = 0, m += 1; y < 3; y++)
        sfield__lanes_store(out + (1 + y) * stride,
                            sfield__row3(m + y * (inverse ? 1 : 3), inverse ? 3 : 1, &h));
    h.x0 = sfield__lanes_load(in + 4 * stride);
    h.x1 = sfield__lanes_load(in + 5 * stride);
    h.x2 = sfield__lanes_load(in + 6 * stride);
    h.x3 = sfield__lanes_load(in + 7 * stride);
    h.x4 = sfield__lanes_load(in + 8 * stride);
    for (y = 0, m += 9; y < 5; y++)
        sfield__lanes_store(out + (4 + y) * stride,
                            sfield__row5(m + y * (inverse ? 1 : 5), inverse ? 5 : 1, &h));
    h.x0 = sfield__lanes_load(in + 9 * stride);
    h.x1 = sfield__lanes_load(in + 10 * stride);
    h.x2 = sfield__lanes_load(in + 11 * stride);
    h.x3 = sfield__lanes_load(in + 12 * stride);
    h.x4 = sfield__lanes_load(in + 13 * stride);
    h.x5 = sfield__lanes_load(in + 14 * stride);
    h.x6 = sfield__lanes_load(in + 15 * stride);
    for (y = 0, m += 25; y < 7; y++)
        sfield__lanes_store(out + (9 + y) * stride,
                            sfield__row7(m + y * (inverse ? 1 : 7), inverse ? 7 : 1, &h));
}
