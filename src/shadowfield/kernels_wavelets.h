/* ---- kernels: wavelets of sixteen points ---- */

static inline SFIELD__IN_KERNEL sfield__lanes sfield__at_least_0(sfield__lanes a)
{
    return sfield__lanes_max(a, sfield__lanes_all(0));
}

/* Returns whether any lane is not 0. */
static inline SFIELD__IN_KERNEL int sfield__any_lane(sfield__lanes a)
{
    return sfield__mask_any(sfield__lanes_differ(a, sfield__lanes_all(0)));
}

/* Fills the texels of a face with T = max(0, cos) x solid angle, and notes the blocks in which T is not 0.
   Returns 0 if there is no such block. */
SFIELD__KERNEL static int sfield__face_start(sfield__bundle *b, const float *texel, uint32_t n)
{
    const sfield__lanes x = sfield__lanes_load(b->n), y = sfield__lanes_load(b->n + 16);
    const sfield__lanes z = sfield__lanes_load(b->n + 32);
    const size_t cells = b->s->cells;
    const uint32_t block = n < SFIELD__BLOCK ? n : (uint32_t)SFIELD__BLOCK;
    uint32_t i, k, any = 0;
    for (i = 0; i < n; i += block) {
        static const uint8_t corner[4] = { 0, 21, 42, 63 };
        sfield__lanes sum = sfield__lanes_all(0);
        for (k = 0; k < 4 && block == SFIELD__BLOCK; k++) {
            const float *q = texel + i + corner[k];
            sfield__lanes d = sfield__lanes_mul(x, sfield__lanes_all(q[0]));
            d = sfield__lanes_muladd(y, sfield__lanes_all(q[cells]), d);
            d = sfield__at_least_0(sfield__lanes_muladd(z, sfield__lanes_all(q[2 * cells]), d));
            sum = sfield__lanes_add(sum, d);
        }
        b->live[i / block] = (uint8_t)(block < SFIELD__BLOCK || sfield__any_lane(sum));
        any |= b->live[i / block];
        if (!b->live[i / block]) continue;          /* all corners, so all of it, below the horizon of all */
        for (k = i; k < i + block; k++) {
            const float *q = texel + k;
            sfield__lanes d = sfield__lanes_mul(x, sfield__lanes_all(q[0]));
            d = sfield__lanes_muladd(y, sfield__lanes_all(q[cells]), d);
            d = sfield__at_least_0(sfield__lanes_muladd(z, sfield__lanes_all(q[2 * cells]), d));
            d = sfield__lanes_mul(d, sfield__lanes_all(q[3 * cells]));
            sfield__lanes_store(b->t + 16 * (size_t)k, d);
        }
    }
    return (int)any;
}

/* Adds the part of a list that lies in this face to planes of wavelets. A square of the planes is cleared
   when it is first used. Returns how many squares are used now. */
SFIELD__KERNEL static uint32_t sfield__face_add_list(sfield__bundle *b, sfield__listing *list, uint32_t last,
                                                     uint32_t count, float factor)
{
    const sfield__lanes zero = sfield__lanes_all(0);
    const sfield__lanes weight = sfield__lanes_mul(sfield__lanes_all(factor),
                                                   sfield__lanes_load(list->weight));
    const uint32_t *e = list->e, *end = list->end, mask = b->s->side * b->s->side - 1;
    float *planes = b->w;
    uint8_t *marks = b->marks;
    for (; e < end && *e < last; e++) {
        const uint32_t index = *e >> 16 & mask;
        uint32_t square = (index - 1) / 3;
        float *w = planes + 16 * (size_t)index;
        for (; index && !marks[square]; square = (square - 1) / 4) {
            float *first = planes + 16 * (size_t)(3 * square + 1);
            marks[square] = 1;
            b->used[count++] = (uint16_t)square;
            sfield__lanes_store(first, zero);
            sfield__lanes_store(first + 16, zero);
            sfield__lanes_store(first + 32, zero);
            if (!square) break;
        }
        sfield__lanes_store(w, sfield__lanes_muladd(sfield__lanes_all(sfield__signed_short(*e)), weight,
                                                 sfield__lanes_load(w)));
    }
    list->e = e;
    return count;
}

/* Multiplies the n texels of square i by 1 - mean, but for blocks in which T is 0. */
SFIELD__KERNEL static void sfield__face_dim(const sfield__bundle *b, uint32_t i, uint32_t n,
                                            const sfield__lanes *mean)
{
    const sfield__lanes keep = sfield__lanes_sub(sfield__lanes_all(1), *mean);
    uint32_t k;
    float *t;
    for (k = i * n; k < (i + 1) * n; k++) {
        if (n >= SFIELD__BLOCK && k % SFIELD__BLOCK == 0 && !b->live[k / SFIELD__BLOCK]) {
            k += SFIELD__BLOCK - 1;
            continue;
        }
        t = b->t + 16 * (size_t)k;
        sfield__lanes_store(t, sfield__lanes_mul(sfield__lanes_load(t), keep));
    }
}

/* Does for sixteen points what sfield__shade_square does for one: multiplies the texels of a marked square
   by 1 - the function below the square. */
SFIELD__KERNEL static void sfield__face_darken(const sfield__bundle *b, uint32_t leaves,
                                               const sfield__lanes *mean, uint32_t squares, uint32_t i,
                                               float scale)
{
    const sfield__lanes s = sfield__lanes_all(scale), one = sfield__lanes_all(1);
    const float *w = b->w + 16 * (size_t)(squares + 3 * i);
    const sfield__lanes x = sfield__lanes_mul(s, sfield__lanes_load(w));
    const sfield__lanes y = sfield__lanes_mul(s, sfield__lanes_load(w + 16));
    const sfield__lanes z = sfield__lanes_mul(s, sfield__lanes_load(w + 32));
    const sfield__lanes a = sfield__lanes_add(*mean, y), d = sfield__lanes_sub(*mean, y);
    const sfield__lanes f = sfield__lanes_add(x, z), g = sfield__lanes_sub(x, z);
    const uint32_t n = leaves / squares, below = (4 * squares - 1) / 3 + 4 * i;
    sfield__lanes m[4];
    uint32_t k;
    if (4 * n == SFIELD__BLOCK && !b->live[i]) return;
    m[0] = sfield__lanes_add(a, f);
    m[1] = sfield__lanes_sub(a, f);
    m[2] = sfield__lanes_add(d, g);
    m[3] = sfield__lanes_sub(d, g);
    for (k = 0; k < 4; k++) {
        float *t = b->t + 16 * (size_t)(4 * i + k);
        if (n == 1)
            sfield__lanes_store(t, sfield__lanes_mul(sfield__lanes_load(t), sfield__lanes_sub(one, m[k])));
        else if (b->marks[below + k]) sfield__face_darken(b, leaves, &m[k], 4 * squares, 4 * i + k,
                                                          2 * scale);
        else if (sfield__any_lane(m[k])) sfield__face_dim(b, 4 * i + k, n, &m[k]);
    }
}

/* Multiplies T by the visibility of an occluder. Returns 0 if the occluder hides nothing in this face. */
SFIELD__KERNEL static int sfield__face_hide(sfield__bundle *b, sfield__strand *strand, const sfield_field *f,
                                            uint32_t last, uint32_t leaves)
{
    const float scale = 1 / (float)b->s->side;
    uint32_t i, count = 0;
    sfield__lanes mean;
    for (i = 0; i < strand->count && !(strand->list[i].e < strand->list[i].end &&
                                       *strand->list[i].e < last);) i++;
    if (i == strand->count) return 0;
    sfield__lanes_store(b->w, sfield__lanes_all(0));
    for (i = 0; i < strand->count; i++)
        count = sfield__face_add_list(b, &strand->list[i], last, count,
                                      f->sample_scale[strand->list[i].sample]);
    mean = sfield__lanes_mul(sfield__lanes_load(b->w), sfield__lanes_all(scale));
    if (b->marks[0]) sfield__face_darken(b, leaves, &mean, 1, 0, scale);
    else sfield__face_dim(b, 0, 4 * leaves, &mean);
    for (i = 0; i < count; i++) b->marks[b->used[i]] = 0;
    return 1;
}

/* Transforms the squares of a level: wavelets go to out, scaling coefficients to up. */
SFIELD__KERNEL static void sfield__face_level(const float *c, uint32_t squares, float *up, float *out)
{
    const sfield__lanes half = sfield__lanes_all(0.5f);
    for (; squares > 0; squares--, c += 64, up += 16, out += 48) {
        const sfield__lanes p = sfield__lanes_load(c), q = sfield__lanes_load(c + 16);
        const sfield__lanes r = sfield__lanes_load(c + 32), s = sfield__lanes_load(c + 48);
        const sfield__lanes a = sfield__lanes_add(p, q), b = sfield__lanes_sub(p, q);
        const sfield__lanes d = sfield__lanes_add(r, s), e = sfield__lanes_sub(r, s);
        sfield__lanes_store(out, sfield__lanes_mul(half, sfield__lanes_add(b, e)));
        sfield__lanes_store(out + 16, sfield__lanes_mul(half, sfield__lanes_sub(a, d)));
        sfield__lanes_store(out + 32, sfield__lanes_mul(half, sfield__lanes_sub(b, e)));
        sfield__lanes_store(up, sfield__lanes_mul(half, sfield__lanes_add(a, d)));
    }
}

/* Finds the wavelets of the face. Blocks of up to 64 texels are transformed one by one, since a block fits
   into the nearest cache. */
SFIELD__KERNEL static void sfield__face_transform(sfield__bundle *b, uint32_t n)
{
    const uint32_t block = n < SFIELD__BLOCK ? n : (uint32_t)SFIELD__BLOCK;
    float sums[16 * SFIELD__BLOCK], part[16 * 21];
    uint32_t i, squares;
    for (i = 0; i < n / block; i++) {
        const float *from = b->t + 16 * (size_t)(i * block);
        float *up = part;
        for (squares = block / 4; squares; squares /= 4) {
            const size_t all = (size_t)squares * (n / block), at = all + 3 * (size_t)squares * i;
            if (b->live[i])
                sfield__face_level(from, squares, squares == 1 ? sums + 16 * i : up, b->w + 16 * at);
            else memset(b->w + 16 * at, 0, 48 * (size_t)squares * sizeof *b->w);
            from = up;
            up += 16 * squares;
        }
        if (!b->live[i]) memset(sums + 16 * i, 0, 16 * sizeof *sums);
    }
    for (squares = n / block / 4; squares; squares /= 4)      /* a sum falls on one that is done */
        sfield__face_level(sums, squares, sums, b->w + 16 * (size_t)squares);
    memcpy(b->w, sums, 16 * sizeof *sums);
}

/* Adds what a light gives in this face: the products of its wavelets with those of T, which are found
   first if T has changed. */
SFIELD__KERNEL static void sfield__face_light(sfield__bundle *b, sfield__strand *strand,
                                              const sfield_field *f, uint32_t last, uint32_t n, int *fresh)
{
    const float *tint = b->s->item[strand->item].e.tint;
    sfield__lanes sum[3];
    uint32_t i, c;
    for (c = 0; c < 3; c++) sum[c] = sfield__lanes_all(0);
    for (i = 0; i < strand->count; i++) {
        sfield__listing *l = &strand->list[i];
        const sfield__lanes weight = sfield__lanes_mul(sfield__lanes_all(f->sample_scale[l->sample]),
                                                     sfield__lanes_load(l->weight));
        for (; l->e < l->end && l->e[0] < last; l->e += 2) {
            sfield__lanes t;
            if (!*fresh) sfield__face_transform(b, n);
            *fresh = 1;
            t = sfield__lanes_mul(weight, sfield__lanes_load(b->w + 16 * (size_t)(l->e[0] >> 16 & (n - 1))));
            sum[0] = sfield__lanes_muladd(t, sfield__lanes_all(sfield__signed_short(l->e[0])), sum[0]);
            sum[1] = sfield__lanes_muladd(t, sfield__lanes_all(sfield__signed_short(l->e[1] >> 16)), sum[1]);
            sum[2] = sfield__lanes_muladd(t, sfield__lanes_all(sfield__signed_short(l->e[1])), sum[2]);
        }
    }
    for (c = 0; c < 3; c++) {
        float *to = b->rgb + 16 * c;
        sfield__lanes_store(to, sfield__lanes_muladd(sfield__lanes_all(tint[c]), sum[c],
                                                     sfield__lanes_load(to)));
    }
}

/* Adds what T leaves of the sky, and of a sky that is white. */
SFIELD__KERNEL static void sfield__face_finish(sfield__bundle *b, const float *sky, uint32_t n)
{
    const size_t cells = b->s->cells;
    const uint32_t block = n < SFIELD__BLOCK ? n : (uint32_t)SFIELD__BLOCK;
    const int ambient = b->ambient;
    sfield__lanes x = sfield__lanes_all(0), y = x, z = x, sum = x;
    uint32_t i, k;
    for (i = 0; i < n; i += block) {
        const float *q = sky + i, *from = b->t + 16 * (size_t)i;
        if (!b->live[i / block]) continue;
        for (k = 0; k < block; k++) {
            const sfield__lanes t = sfield__lanes_load(from + 16 * (size_t)k);
            x = sfield__lanes_muladd(t, sfield__lanes_all(q[k]), x);
            y = sfield__lanes_muladd(t, sfield__lanes_all(q[cells + k]), y);
            z = sfield__lanes_muladd(t, sfield__lanes_all(q[2 * cells + k]), z);
        }
        for (k = 0; k < block && ambient; k++)
            sum = sfield__lanes_add(sum, sfield__lanes_load(from + 16 * (size_t)k));
    }
    if (b->s->has_sky || b->s->has_sun) {
        sfield__lanes_store(b->rgb, sfield__lanes_add(x, sfield__lanes_load(b->rgb)));
        sfield__lanes_store(b->rgb + 16, sfield__lanes_add(y, sfield__lanes_load(b->rgb + 16)));
        sfield__lanes_store(b->rgb + 32, sfield__lanes_add(z, sfield__lanes_load(b->rgb + 32)));
    }
    sfield__lanes_store(b->open, sfield__lanes_add(sum, sfield__lanes_load(b->open)));
}

/* Shades one face for all points of a bundle: T is started, then goes through the entities from near to
   far. */
SFIELD__KERNEL static void sfield__face_shade(sfield__bundle *b, const sfield_field *self, uint32_t face)
{
    const sfield_scene *s = b->s;
    const uint32_t n = s->side * s->side, first = face * n << 16, last = (face + 1) * n << 16;
    uint32_t i, k;
    int fresh = 0;                          /* b->w are the wavelets of b->t */
    if (!sfield__face_start(b, s->texel + face * n, n)) return;
    for (i = 0; i < b->strands; i++) {
        sfield__strand *strand = &b->strand[i];
        const sfield_entity *e = strand->light < -1 ? NULL : &s->item[strand->item].e;
        const sfield_field *f = !e ? self : strand->light < 0 ? e->occlusion : e->source;
        for (k = 0; k < strand->count; k++)
            while (strand->list[k].e < strand->list[k].end && *strand->list[k].e < first)
                strand->list[k].e += f->h.stride;
        if (strand->light >= 0) sfield__face_light(b, strand, f, last, n, &fresh);
        else if (sfield__face_hide(b, strand, f, last, n / 4)) fresh = 0;
    }
    sfield__face_finish(b, s->sky_now + face * n, n);
}
