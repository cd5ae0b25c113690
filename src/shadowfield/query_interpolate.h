/* ---- queries: where points lie in a field ---- */

typedef struct sfield__place {      /* of 16 points in a field */
    int32_t base[SFIELD__LANES];    /* sample of the inner shell, lower corner */
    int32_t shell[SFIELD__LANES];
    float   fx[SFIELD__LANES], fy[SFIELD__LANES];
    float   w0[SFIELD__LANES], w1[SFIELD__LANES];       /* of the inner and the outer shell */
} sfield__place;

/* Finds where 16 points lie in a field. p: planes of x, y, z about the center, in r, finite. */
static void sfield__locate16(const sfield_field *f, const float *p, sfield__place *out, int simd);

/* Returns the bits of the points with the wanted base. */
static uint32_t sfield__same16(const int32_t *base, int32_t wanted, int simd);

/* Copies n floats, planes of 16, with zeros where a mask has no bit. */
static void sfield__select16(const float *in, uint32_t n, uint32_t mask, float *out, int simd);

/* Finds the frames before and after a time; returns how far it lies between them. Loops wrap both ways. */
static float sfield__frames_at(const sfield_field *f, float time, uint32_t *before, uint32_t *after)
{
    float n = (float)f->h.frames, t = sfield__finite(time) ? time * f->h.frames_per_second : 0;
    *before = *after = 0;
    if (f->h.frames == 1) return 0;
    if (f->h.loop) {
        t = t < 1e7f ? (t > -1e7f ? t : -1e7f) : 1e7f;
        t -= n * floorf(t / n);
    }
    t = t > 0 ? t : 0;
    t = t < n ? t : (f->h.loop ? 0 : n);
    *before = (uint32_t)t < f->h.frames - 1 ? (uint32_t)t : f->h.frames - 1;
    *after = *before + 1 < f->h.frames ? *before + 1 : f->h.loop ? 0 : *before;
    return t - (float)*before < 1 ? t - (float)*before : 0;
}

/* Computes the weights of the four corners of the square of a shell that a lane lies in. */
static void sfield__weigh_corners(const sfield__place *at, int l, float *b)
{
    float x = at->fx[l], y = at->fy[l];
    b[0] = (1 - x) * (1 - y);
    b[1] = x * (1 - y);
    b[2] = (1 - x) * y;
    b[3] = x * y;
}

/* The eight samples between which a point lies, and the weight of each. */
typedef struct sfield__between {
    size_t base, group;             /* sample and scales of the inner shell's first corner */
    float  corner[4];               /* weights of the corners of both shells */
    float  inner, outer;            /* weights of the shells */
} sfield__between;

/* Finds the samples about lane l of a place, in the first frame, with a share of their weight. */
static sfield__between sfield__find_between(const sfield__place *at, int l, float share)
{
    sfield__between b;
    b.base = (size_t)at->base[l];
    b.group = (size_t)at->shell[l];
    sfield__weigh_corners(at, l, b.corner);
    b.inner = at->w0[l] * share;
    b.outer = at->w1[l] * share;
    return b;
}

/* Returns the same samples of another frame of a source. */
static sfield__between sfield__between_of_frame(const sfield_field *f, const sfield__between *first,
                                                uint32_t frame)
{
    sfield__between b = *first;
    b.base += frame * 6 * (size_t)f->h.position_side * f->h.position_side * f->h.shells;
    b.group += frame * f->h.shells;
    return b;
}

/* ---- queries: the eight samples about a point, interpolated ---- */

/* Writes out[k], the sum over eight samples, for k < n, a multiple of 8. Kernels work on sixteen values at
   a time: up to eight floats after out[n - 1] are written, too. */
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

/* Groups lanes by the eight samples that they lie between. Returns how many; 0 if lane by lane costs less. */
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
