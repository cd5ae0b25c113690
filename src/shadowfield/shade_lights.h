/* ---- shading: what lights add ---- */

/* Adds a source's dot products with T: of one channel, where the others are multiples of it. */
static void sfield__add_source(const sfield__item *it, const float (*sum)[SFIELD__LANES], float *rgb)
{
    const sfield_field *f = it->e.source;
    uint32_t c, l;
    for (c = 0; c < 3; c++, rgb += SFIELD__LANES) {
        const float *row = sum[f->tone < 3 ? f->tone : c], tint = it->e.tint[c];
        const float ratio = f->tone < 3 ? f->ratio[c] : 1.0f;
        float own[SFIELD__LANES];               /* a copy, so that compilers know it apart from rgb */
        for (l = 0; l < SFIELD__LANES; l++) own[l] = ratio * row[l];
        for (l = 0; l < SFIELD__LANES; l++) rgb[l] += tint * own[l];
    }
}

/* Computes the dot products of a source's coefficients with T. Each lane is interpolated by itself. */
static void sfield__shine_single(const sfield__tile *t, const sfield__item *it, const sfield__place *at,
                                 const float *chain, float (*sum)[SFIELD__LANES])
{
    const sfield_field *f = it->e.source;
    const uint32_t n = t->s->coefs, begin = f->tone < 3 ? f->tone : 0, end = f->tone < 3 ? f->tone + 1 : 3;
    uint32_t frame[2], c, k, l;
    const float time = sfield__frames_at(f, it->e.time, &frame[0], &frame[1]);
    for (k = 0; k < (time > 0 ? 2u : 1u); k++) {
        float share[SFIELD__LANES];
        for (l = 0; l < SFIELD__LANES; l++) share[l] = k ? time : 1 - time;
        for (c = begin; c < end; c++)
            sfield__dot_single(f, at, frame[k], share, c * n, n, chain, t->rows, sum[c], t->s->simd);
    }
}

/* Does what sfield__shine_single does for lanes that share samples, group by group, which costs less. Returns
   0, with nothing done, if they do not share enough. */
static int sfield__shine_shared(const sfield__tile *t, const sfield__item *it, const sfield__place *at,
                                const float *chain, float (*sum)[SFIELD__LANES])
{
    const sfield_field *f = it->e.source;
    const uint32_t n = t->s->coefs, shells = f->h.shells;
    const uint32_t begin = f->tone < 3 ? f->tone : 0, end = f->tone < 3 ? f->tone + 1 : 3;
    const size_t samples = 6 * (size_t)f->h.position_side * f->h.position_side * shells;
    uint32_t group[SFIELD__LANES], frame[2];
    uint32_t i, k, c, l;
    const uint32_t count = sfield__group_lanes(at, t->in_view, group, t->s->simd);
    float weight[2][SFIELD__LANES], own[SFIELD__LANES];
    const float time = sfield__frames_at(f, it->e.time, &frame[0], &frame[1]);
    for (l = 0; l < SFIELD__LANES; l++) {
        weight[0][l] = 1 - time;
        weight[1][l] = time;
    }
    for (i = 0; i < count; i++) {
        for (l = 0; !(group[i] >> l & 1);) l++;
        for (k = 0; k < (time > 0 ? 2u : 1u); k++) {
            sfield__select16(weight[k], SFIELD__LANES, group[i], own, t->s->simd);
            for (c = begin; c < end; c++) {
                sfield__eight e;
                sfield__load_eight(f, frame[k] * samples + (size_t)at->base[l],
                                   frame[k] * shells + (size_t)at->shell[l], c * n, n, &e, t->s->simd);
                sfield__dot_eight(&e, at, own, chain, sum[c], t->s->simd);
            }
        }
    }
    return count != 0;
}

/* Does what sfield__shine_single does for bands whose coefficients do not fill eights: one after another. */
static void sfield__shine_rows(const sfield__tile *t, const sfield__item *it, const sfield__place *at,
                               const float *chain, float (*sum)[SFIELD__LANES])
{
    const sfield_field *f = it->e.source;
    const sfield_scene *s = t->s;
    float *rows = t->rows;
    uint32_t l, c, k;
    for (l = 0; l < SFIELD__LANES; l++)
        sfield__fetch_lane(f, at, (int)l, it->e.time, f->h.stride, rows + l * f->h.stride, s->simd);
    for (l = 0; l < SFIELD__LANES; l++)
        for (c = 0; c < 3; c++) {
            const float *row = rows + l * f->h.stride + c * s->planes;
            if (f->tone < 3 && c != f->tone) continue;
            for (k = 0; k < s->coefs; k++) sum[c][l] += row[k] * chain[k * SFIELD__LANES + l];
        }
}

/* Adds T . source of light j to rgb, three channels. */
static void sfield__shine_light(const sfield__tile *t, uint32_t j, const float *chain, float *rgb)
{
    const sfield_scene *s = t->s;
    const sfield__item *it = &s->item[s->light[j]];
    float local[48], sum[3][SFIELD__LANES] = { { 0 } };
    sfield__place at;
    sfield__move_to_local(it, 1, t->p, local, s->simd);
    sfield__locate16(it->e.source, local, &at, s->simd);
    if (!it->identity) {
        sfield__rotate16(&s->rotation[s->light[j]], chain, t->turned, SFIELD__LANES, 1, s->simd);
        chain = t->turned;
    }
    if (s->coefs % 8 != 0) sfield__shine_rows(t, it, &at, chain, sum);
    else if (!sfield__shine_shared(t, it, &at, chain, sum)) sfield__shine_single(t, it, &at, chain, sum);
    sfield__add_source(it, (const float (*)[SFIELD__LANES])sum, rgb);
}

static void sfield__sum_lights(const sfield__tile *t, int chain, float *rgb)
{
    const sfield_scene *s = t->s;
    uint32_t j, c, k;
    uint32_t l, n = s->coefs * SFIELD__LANES;
    memset(rgb, 0, 3 * SFIELD__LANES * sizeof *rgb);
    for (j = 0; j < t->lights; j++)
        if (!sfield__is_own(t, j))
            sfield__shine_light(t, j, t->t + ((size_t)j * (size_t)t->chains + (size_t)chain) * n, rgb);
    if (!s->has_sky && !s->has_sun) return;
    for (c = 0; c < 3; c++) {
        const float *sky = s->sky_now + c * s->planes;
        const float *light = t->t + ((size_t)t->lights * (size_t)t->chains + (size_t)chain) * n;
        for (k = 0; k < s->coefs; k++)
            for (l = 0; l < SFIELD__LANES; l++)
                rgb[c * SFIELD__LANES + l] += sky[k] * light[k * SFIELD__LANES + l];
    }
}

static void sfield__store_rgb(const sfield__tile *t, const float *rgb, float factor, float *out)
{
    uint32_t l, c;
    for (l = 0; l < t->lanes; l++)
        for (c = 0; c < 3; c++)
            out[3 * (t->first + l) + c] = t->in_view >> l & 1 ? rgb[c * SFIELD__LANES + l] * factor : 0.0f;
}

#ifndef SFIELD_WITHOUT_GLOSS
static void sfield__write_materials(const sfield__tile *t);
#endif

static void sfield__write_outputs(sfield__tile *t)
{
    const sfield_points *set = t->set;
    float rgb[3 * SFIELD__LANES];
    uint32_t l, n = t->s->coefs * SFIELD__LANES;
    const float *sky = t->t + (size_t)t->lights * (size_t)t->chains * n;
#ifndef SFIELD_WITHOUT_GLOSS
    if (t->chains == 3) {
        sfield__write_materials(t);
        return;
    }
#endif
    if (set->rgb) {
        sfield__sum_lights(t, 0, rgb);
        sfield__store_rgb(t, rgb, 0.318309886f, set->rgb);
    }
#ifndef SFIELD_WITHOUT_GLOSS
    if (set->gloss) {
        if (t->chains == 2) sfield__sum_lights(t, 1, rgb);
        else memset(rgb, 0, sizeof rgb);
        sfield__store_rgb(t, rgb, 1, set->gloss);
        memset(rgb, 0, sizeof rgb);
        if (set->grazing) sfield__store_rgb(t, rgb, 1, set->grazing);
    }
#endif
    for (l = 0; l < t->lanes && set->ambient; l++)
        set->ambient[t->first + l] = t->in_view >> l & 1 ? sky[l] * 0.318309886f / sfield__y00 : 0.0f;
}
