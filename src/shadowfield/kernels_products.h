/* ---- kernels: products of sixteen pairs of vectors ---- */

/* Returns a_i b_j + a_j b_i, or a_i b_i if i is j. */
static SFIELD__IN_LARGE_KERNEL sfield__lanes sfield__pair(const float *a, const float *b, size_t stride,
                                                                 uint32_t i, uint32_t j)
{
    const float *bi = b + i * stride, *aj = a + j * stride;
    const sfield__lanes one = sfield__lanes_mul(sfield__lanes_load(a + i * stride),
                                                sfield__lanes_load(b + j * stride));
    return i == j ? one : sfield__lanes_muladd(sfield__lanes_load(bi), sfield__lanes_load(aj), one);
}

/* Writes to r, a place for each output, the terms that have an index 0. These need no table, since the
   tripling coefficients C_0jj are Y_00 for every j. */
static inline SFIELD__IN_KERNEL void sfield__product_begin(const float *a, const float *b, size_t stride,
                                                           uint32_t coefs, sfield__lanes *r)
{
    const sfield__lanes y00 = sfield__lanes_all(sfield__y00);
    const sfield__lanes a0 = sfield__lanes_mul(sfield__lanes_load(a), y00);
    const sfield__lanes b0 = sfield__lanes_mul(sfield__lanes_load(b), y00);
    sfield__lanes sum = sfield__lanes_mul(sfield__lanes_load(a), sfield__lanes_load(b));
    uint32_t k;
    for (k = 1; k < coefs; k++) {
        const sfield__lanes ak = sfield__lanes_load(a + k * stride), bk = sfield__lanes_load(b + k * stride);
        sum = sfield__lanes_muladd(ak, bk, sum);
        r[k] = sfield__lanes_muladd(b0, ak, sfield__lanes_mul(a0, bk));
    }
    r[0] = sfield__lanes_mul(sum, y00);
}

/* Writes the products r, or with occlude a - r, which is a times a visibility of 1 - b. */
static inline SFIELD__IN_KERNEL void sfield__product_end(const float *a, size_t stride, uint32_t coefs,
                                                         int occlude, const sfield__lanes *r, float *out)
{
    uint32_t k;
    for (k = 0; k < coefs; k++)
        sfield__lanes_store(out + k * stride, !occlude ? r[k] :
                                              sfield__lanes_sub(sfield__lanes_load(a + k * stride), r[k]));
}

/* Pairs a_i b_j + a_j b_i are made once and serve one to three outputs. From 6 bands on they would pass what
   a stack should hold, so that they are made again for every use. */
SFIELD__KERNEL static void sfield__product(const sfield_algebra *t, const float *a, const float *b,
                                           float *out, size_t stride, int occlude)
{
    sfield__lanes p[SFIELD__STAGED + SFIELD__STAGED_COEFS], *r, sum;
    uint32_t i, k, q, staged = t->pair_count <= SFIELD__STAGED;
    r = p + (staged ? SFIELD__STAGED : 0);
    for (i = 1; i < t->coefs && staged; i++)
        for (q = t->row[i]; q < t->row[i + 1]; q++) p[q] = sfield__pair(a, b, stride, i, t->pair[q]);
    sfield__product_begin(a, b, stride, t->coefs, r);
    for (k = 1; k < t->coefs; k++) {
        const sfield__entry *e = t->entry + t->first[k], *end = t->entry + t->first[k + 1];
        sum = r[k];
        if (staged)
            for (; e < end; e++) sum = sfield__lanes_muladd(sfield__lanes_all(e->c), p[e->pair], sum);
        else
            for (; e < end; e++)
                sum = sfield__lanes_muladd(sfield__lanes_all(e->c),
                                           sfield__pair(a, b, stride, t->pair_i[e->pair], t->pair[e->pair]),
                                           sum);
        r[k] = sum;
    }
    sfield__product_end(a, stride, t->coefs, occlude, r, out);
}
