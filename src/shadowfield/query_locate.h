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

/* Finds the frames before and after a time, and returns how far it is on the way. Loops have no beginning
   either. */
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
