/* ---- kernels: between eight samples ---- */

/* What sixteen points between the same eight samples take of each. */
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

/* A coefficient of one shell: q its four samples, n apart. */
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

/* Scale and bias of both shells, copied: what a kernel stores might lie in anything that a pointer leads
   to. */
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

/* out: n planes, to which the coefficients are added where there are more to come. */
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

/* sum: to which every lane's dot product with t, n planes, is added. */
SFIELD__KERNEL static void sfield__eight_times(const sfield__eight *c, const sfield__place *at,
                                               const float *factor, const float *t, float *sum)
{
    const sfield__corner_weights w = sfield__corner_weights_of(at, factor);
    const sfield__shells s = sfield__shells_of(c);
    const sfield__lanes one = sfield__lanes_all(1);
    sfield__lanes part[8];
    uint32_t k, i;
    for (k = 0; k < s.n; k++) {
        const sfield__lanes a = sfield__between_eight(&w, &s, k), x = sfield__lanes_load(t + 16 * k);
        part[k & 7] = k < 8 ? sfield__lanes_mul(a, x) : sfield__lanes_muladd(a, x, part[k & 7]);
    }
    for (k = 4; k > 0; k /= 2)
        for (i = 0; i < k; i++) part[i] = sfield__lanes_muladd(part[i], one, part[i + k]);
    sfield__lanes_store(sum, sfield__lanes_muladd(part[0], one, sfield__lanes_load(sum)));
}
