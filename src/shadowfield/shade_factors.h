/* ---- shading: the factors of the triple product ---- */

/* Evaluates the basis at 16 directions in planes, in float. */
static void sfield__evaluate_basis16(uint32_t bands, const float *d, float *out)
{
    float cm[16], sm[16], older[16];
    float now[16], diagonal = sfield__y00;
    uint32_t l, m, i;
    for (i = 0; i < 16; i++) {
        cm[i] = 1;
        sm[i] = 0;
    }
    for (m = 0; m < bands; m++) {
        float two = m ? 1.41421356f * diagonal : diagonal;
        for (i = 0; i < 16; i++) {
            older[i] = 0;
            now[i] = two;
        }
        for (l = m; l < bands; l++) {
            float fl = (float)l, fm = (float)m, back = sqrtf((fl * fl - fm * fm) / (4 * fl * fl - 1));
            float a = sqrtf((4 * (fl + 1) * (fl + 1) - 1) / ((fl + 1) * (fl + 1) - fm * fm));
            float *plus = out + (l * l + l + m) * 16, *minus = out + (l * l + l - m) * 16;
            if (l == 0) back = 0;
            for (i = 0; i < 16; i++) {
                float next = a * (d[32 + i] * now[i] - back * older[i]);
                minus[i] = now[i] * sm[i];
                plus[i] = now[i] * cm[i];
                older[i] = now[i];
                now[i] = next;
            }
        }
        diagonal *= sqrtf((2 * (float)m + 3) / (2 * (float)m + 2));
        for (i = 0; i < 16; i++) {
            float c = cm[i] * d[i] - sm[i] * d[16 + i];
            sm[i] = cm[i] * d[16 + i] + sm[i] * d[i];
            cm[i] = c;
        }
    }
}

#ifndef SFIELD_WITHOUT_GLOSS
static void sfield__start_gloss(sfield__tile *t);
#endif

/* Computes T before any other entity: own visibility times the cosine, and that times the BRDF. */
static void sfield__start_tile(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    const sfield_field *self = t->set->self;
    uint32_t k, l, i;
    if (self) {
        for (i = 0; i < SFIELD__LANES; i++) {
            const uint8_t *q = self->sample + (t->first + (i < t->lanes ? i : 0)) * self->h.stride;
            for (k = 0; k < s->coefs; k++)
                t->start[k * SFIELD__LANES + i] = self->scale[k] * (float)q[k] + self->bias[k];
        }
        if (t->set->entity && !s->item[t->set->entity - 1].identity)
            sfield__rotate16(&s->rotation[t->set->entity - 1], t->start, t->start, SFIELD__LANES, 0, s->simd);
    } else {
        float factor[SFIELD_MAX_BANDS];
        sfield_sh_cosine(s->desc.bands, factor);
        sfield__evaluate_basis16(s->desc.bands, t->n, t->start);
        for (l = 0, k = 0; l < s->desc.bands; l++)
            for (; k < (l + 1) * (l + 1) * SFIELD__LANES; k++) t->start[k] *= factor[l];
    }
#ifndef SFIELD_WITHOUT_GLOSS
    if (t->chains > 1) sfield__start_gloss(t);
#endif
}

/* Interpolates some lanes of a field at their places, times a factor, in planes; the others are 0. */
static void sfield__fetch_lanes(const sfield_field *f, const sfield__place *at, uint32_t lanes,
                            const float *factor, float *rows, float *planes, int simd)
{
    const uint32_t n = f->planes;
    uint32_t group[SFIELD__LANES], count = sfield__group_lanes(at, lanes, group, simd), i, l;
    for (i = 0; i < count; i++) {
        sfield__eight e;
        float own[SFIELD__LANES];
        for (l = 0; !(group[i] >> l & 1);) l++;
        sfield__load_eight(f, (size_t)at->base[l], (size_t)at->shell[l], 0, n, &e, simd);
        sfield__select16(factor, SFIELD__LANES, group[i], own, simd);
        sfield__mix_eight(&e, at, own, i > 0, planes, simd);
    }
    if (count) return;
    for (l = 0; l < SFIELD__LANES; l++, rows += n) {
        sfield__between b;
        if (!(lanes >> l & 1)) {
            memset(rows, 0, n * sizeof *rows);
            continue;
        }
        b = sfield__find_between(at, (int)l, factor[l]);
        sfield__mix_samples(f, &b, n, rows, simd);
    }
    sfield__rows_to_planes(rows - SFIELD__LANES * n, n, n, planes, simd);
}

/* Fetches alpha (or log visibility) of occluder i for all lanes, in planes, in the world. */
static void sfield__fetch_occluder(sfield__tile *t, uint32_t i)
{
    const sfield_scene *s = t->s;
    const sfield__item *it = &s->item[t->item[i]];
    float local[48], *planes = it->identity && s->planes == s->coefs ? NULL : t->planes;
    float *out = t->occlusion + (size_t)i * s->coefs * SFIELD__LANES;
    sfield__place at;
    uint32_t hidden;
    if (t->state[i] != SFIELD__NOT_FETCHED) return;
    hidden = sfield__find_hidden(t, i, t->used[i]);
    t->stats.culled_hidden += sfield__popcount(hidden);
    t->shown[i] = t->used[i] & ~hidden;
    t->state[i] = t->shown[i] ? SFIELD__FETCHED : SFIELD__ALL_HIDDEN;
    if (!t->shown[i]) return;
    sfield__move_to_local(it, 0, t->p, local, s->simd);
    sfield__locate16(it->e.occlusion, local, &at, s->simd);
    sfield__fetch_lanes(it->e.occlusion, &at, t->shown[i], t->factor + (size_t)i * SFIELD__LANES, t->rows,
                    planes ? planes : out, s->simd);
    if (!planes) return;
    if (it->identity) memcpy(out, planes, s->coefs * SFIELD__LANES * sizeof *out);
    else sfield__rotate16(&s->rotation[t->item[i]], planes, out, SFIELD__LANES, 0, s->simd);
}

/* Multiplies t by the visibility of occluder i, for the lanes of a mask. */
static void sfield__apply_occluder(sfield__tile *t, uint32_t i, uint32_t mask, float *chain)
{
    const sfield_scene *s = t->s;
    const float *o = t->occlusion + (size_t)i * s->coefs * SFIELD__LANES;
    int c;
    if (t->state[i] == SFIELD__ALL_HIDDEN || !mask) return;
    if (mask != t->used[i]) {
        sfield__select16(o, s->coefs * SFIELD__LANES, mask, t->turned, s->simd);
        o = t->turned;
    }
    t->stats.products += sfield__popcount(mask);
    for (c = 0; c < t->chains; c++, chain += s->coefs * SFIELD__LANES)
        sfield__product16(s->algebra, chain, o, chain, SFIELD__LANES, 1);
}
