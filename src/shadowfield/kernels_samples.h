/* ---- kernels: between eight samples ---- */

/* See sfield__widen_samples. What is written after a sample's last value gives way to the next sample. */
SFIELD__KERNEL static void sfield__widen(const sfield_field *f, const uint8_t *first, uint32_t n, float *out)
{
    const size_t stride = f->h.stride, row = f->h.position_side * stride,
                 shell = 6 * f->h.position_side * row;
    uint32_t i, k;
    for (i = 0; i < 8; i++, out += n) {
        const uint8_t *q = first + (i & 1) * stride + (i >> 1 & 1) * row + (i >> 2) * shell;
        for (k = 0; k < n; k += 16) sfield__lanes_store(out + k, sfield__lanes_of_bytes(q + k));
    }
}

/* See sfield__rows_to_planes. */
SFIELD__KERNEL static void sfield__transpose(const float *rows, size_t stride, uint32_t n, float *planes)
{
    uint32_t k, l;
    for (k = 0; k < n; k += 8)
        for (l = 0; l < 16; l += 8)
            sfield__transpose8(rows + l * stride + k, stride, planes + 16 * k + l, 16);
}

/* The weights that sixteen points between the same eight samples give to each of these. */
typedef struct sfield__corner_weights {
    sfield__lanes x0, x1, x2, x3;   /* of the corners of a shell */
    sfield__lanes w0, w1;           /* of the shells */
} sfield__corner_weights;

static inline SFIELD__IN_KERNEL sfield__corner_weights sfield__corner_weights_of(const sfield__place *at,
                                                                                 const float *factor)
{
    const sfield__lanes one = sfield__lanes_all(1), own = sfield__lanes_load(factor);
    const sfield__lanes fx = sfield__lanes_load(at->fx), fy = sfield__lanes_load(at->fy);
    const sfield__lanes gx = sfield__lanes_sub(one, fx), gy = sfield__lanes_sub(one, fy);
    sfield__corner_weights w;
    w.x0 = sfield__lanes_mul(gx, gy);
    w.x1 = sfield__lanes_mul(fx, gy);
    w.x2 = sfield__lanes_mul(gx, fy);
    w.x3 = sfield__lanes_mul(fx, fy);
    w.w0 = sfield__lanes_mul(sfield__lanes_load(at->w0), own);
    w.w1 = sfield__lanes_mul(sfield__lanes_load(at->w1), own);
    return w;
}

/* Interpolates n coefficients, from one on, of one point, sixteen of them at a time. base and group: the
   sample and the scales of the inner shell's first corner. The weights are the same in all lanes. */
static inline SFIELD__IN_KERNEL void sfield__mix_row(const sfield_field *f, size_t base, size_t group,
                                                     uint32_t from, uint32_t n,
                                                     const sfield__corner_weights *w, float *out)
{
    const size_t stride = f->h.stride, row = f->h.position_side * stride,
                 shell = 6 * f->h.position_side * row;
    const uint8_t *q = f->sample + base * stride + from;
    const float *s0 = f->scale + group * stride + from, *b0 = f->bias + group * stride + from;
    uint32_t k;
    for (k = 0; k < n; k += 16, q += 16) {
        sfield__lanes a = sfield__lanes_mul(sfield__lanes_of_bytes(q), w->x0);
        sfield__lanes c = sfield__lanes_mul(sfield__lanes_of_bytes(q + shell), w->x0);
        a = sfield__lanes_muladd(sfield__lanes_of_bytes(q + stride), w->x1, a);
        c = sfield__lanes_muladd(sfield__lanes_of_bytes(q + shell + stride), w->x1, c);
        a = sfield__lanes_muladd(sfield__lanes_of_bytes(q + row), w->x2, a);
        c = sfield__lanes_muladd(sfield__lanes_of_bytes(q + shell + row), w->x2, c);
        a = sfield__lanes_muladd(sfield__lanes_of_bytes(q + row + stride), w->x3, a);
        c = sfield__lanes_muladd(sfield__lanes_of_bytes(q + shell + row + stride), w->x3, c);
        a = sfield__lanes_muladd(a, sfield__lanes_load(s0 + k), sfield__lanes_load(b0 + k));
        c = sfield__lanes_muladd(c, sfield__lanes_load(s0 + stride + k), sfield__lanes_load(b0 + stride + k));
        sfield__lanes_store(out + k, sfield__lanes_muladd(c, w->w1, sfield__lanes_mul(a, w->w0)));
    }
}

/* See sfield__mix_samples. */
SFIELD__KERNEL static void sfield__mix(const sfield_field *f, const sfield__between *at, uint32_t n,
                                       float *out)
{
    sfield__corner_weights w;
    w.x0 = sfield__lanes_all(at->corner[0]);
    w.x1 = sfield__lanes_all(at->corner[1]);
    w.x2 = sfield__lanes_all(at->corner[2]);
    w.x3 = sfield__lanes_all(at->corner[3]);
    w.w0 = sfield__lanes_all(at->inner);
    w.w1 = sfield__lanes_all(at->outer);
    sfield__mix_row(f, at->base, at->group, 0, n, &w, out);
}

/* Interpolates one coefficient between the four samples of a shell: q[0], q[n], q[2 n] and q[3 n]. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__between_four(const sfield__corner_weights *w,
                                                                   const float *q,
                                                                   uint32_t n, float scale, float bias)
{
    sfield__lanes sum = sfield__lanes_mul(sfield__lanes_all(q[0]), w->x0);
    sum = sfield__lanes_muladd(sfield__lanes_all(q[n]), w->x1, sum);
    sum = sfield__lanes_muladd(sfield__lanes_all(q[2 * n]), w->x2, sum);
    sum = sfield__lanes_muladd(sfield__lanes_all(q[3 * n]), w->x3, sum);
    return sfield__lanes_muladd(sum, sfield__lanes_all(scale), sfield__lanes_all(bias));
}

/* Copies of the pointers to scale and bias of both shells, or compilers load them again after every store. */
typedef struct sfield__shells { const float *q, *s0, *b0, *s1, *b1; uint32_t n; } sfield__shells;

static inline SFIELD__IN_KERNEL sfield__shells sfield__shells_of(const sfield__eight *c)
{
    sfield__shells s;
    s.q = c->q;
    s.s0 = c->s0;
    s.b0 = c->b0;
    s.s1 = c->s1;
    s.b1 = c->b1;
    s.n = c->n;
    return s;
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__between_eight(const sfield__corner_weights *w,
                                                                    const sfield__shells *s, uint32_t k)
{
    const sfield__lanes inner = sfield__between_four(w, s->q + k, s->n, s->s0[k], s->b0[k]);
    const sfield__lanes outer = sfield__between_four(w, s->q + 4 * s->n + k, s->n, s->s1[k], s->b1[k]);
    return sfield__lanes_muladd(outer, w->w1, sfield__lanes_mul(inner, w->w0));
}

/* Interpolates between eight samples, for the lanes by their factors. out holds n planes; unless more is 0
   the coefficients are added to what the planes hold. */
SFIELD__KERNEL static void sfield__eight_to_planes(const sfield__eight *c, const sfield__place *at,
                                                   const float *factor, int more, float *out)
{
    const sfield__corner_weights w = sfield__corner_weights_of(at, factor);
    const sfield__shells s = sfield__shells_of(c);
    const sfield__lanes one = sfield__lanes_all(1);
    uint32_t k;
    for (k = 0; k < s.n; k++, out += 16) {
        sfield__lanes a = sfield__between_eight(&w, &s, k);
        if (more) a = sfield__lanes_muladd(sfield__lanes_load(out), one, a);
        sfield__lanes_store(out, a);
    }
}

/* Adds up eight sums of every lane: the second four to the first four, then halves again. */
static inline SFIELD__IN_KERNEL void sfield__add_parts(sfield__lanes *part, float *sum)
{
    const sfield__lanes one = sfield__lanes_all(1);
    uint32_t k, i;
    for (k = 4; k > 0; k /= 2)
        for (i = 0; i < k; i++) part[i] = sfield__lanes_muladd(part[i], one, part[i + k]);
    sfield__lanes_store(sum, sfield__lanes_muladd(part[0], one, sfield__lanes_load(sum)));
}

/* Adds every lane's dot product with t, n planes, to sum. */
SFIELD__KERNEL static void sfield__eight_times(const sfield__eight *c, const sfield__place *at,
                                               const float *factor, const float *t, float *sum)
{
    const sfield__corner_weights w = sfield__corner_weights_of(at, factor);
    const sfield__shells s = sfield__shells_of(c);
    sfield__lanes part[8];
    uint32_t k;
    for (k = 0; k < s.n; k++) {
        const sfield__lanes a = sfield__between_eight(&w, &s, k), x = sfield__lanes_load(t + 16 * k);
        part[k & 7] = k < 8 ? sfield__lanes_mul(a, x) : sfield__lanes_muladd(a, x, part[k & 7]);
    }
    sfield__add_parts(part, sum);
}

/* Does what sfield__eight_times does, with the same bits, for coefficients that are in planes already. */
SFIELD__KERNEL static void sfield__planes_times(const float *planes, const float *t, uint32_t n, float *sum)
{
    sfield__lanes part[8];
    uint32_t k;
    for (k = 0; k < n; k++) {
        const sfield__lanes a = sfield__lanes_load(planes + 16 * k), x = sfield__lanes_load(t + 16 * k);
        part[k & 7] = k < 8 ? sfield__lanes_mul(a, x) : sfield__lanes_muladd(a, x, part[k & 7]);
    }
    sfield__add_parts(part, sum);
}

/* See sfield__dot_single. */
SFIELD__KERNEL static void sfield__singles_times(const sfield_field *f, const sfield__place *at,
                                                 uint32_t frame, const float *factor, uint32_t from,
                                                 uint32_t n, const float *t, float *room, float *sum)
{
    const sfield__corner_weights all = sfield__corner_weights_of(at, factor);
    const size_t sample = frame * 6 * (size_t)f->h.position_side * f->h.position_side * f->h.shells;
    const size_t group = (size_t)frame * f->h.shells;
    float *planes = room + 16 * n, each[6][16];
    uint32_t l;
    sfield__lanes_store(each[0], all.x0);
    sfield__lanes_store(each[1], all.x1);
    sfield__lanes_store(each[2], all.x2);
    sfield__lanes_store(each[3], all.x3);
    sfield__lanes_store(each[4], all.w0);
    sfield__lanes_store(each[5], all.w1);
    for (l = 0; l < 16; l++) {
        sfield__corner_weights w;
        w.x0 = sfield__lanes_all(each[0][l]);
        w.x1 = sfield__lanes_all(each[1][l]);
        w.x2 = sfield__lanes_all(each[2][l]);
        w.x3 = sfield__lanes_all(each[3][l]);
        w.w0 = sfield__lanes_all(each[4][l]);
        w.w1 = sfield__lanes_all(each[5][l]);
        sfield__mix_row(f, sample + (size_t)at->base[l], group + (size_t)at->shell[l], from, n, &w,
                        room + l * n);
    }
    sfield__transpose(room, n, n, planes);
    sfield__planes_times(planes, t, n, sum);
}
