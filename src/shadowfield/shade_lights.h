/* ---- shading: what lights add ---- */

#if SFIELD__SIMD
/* Interpolates a source's channels of n coefficients as sfield__mix_samples would, and adds their dot
   products with t to rgb. */
SFIELD__TARGET_AVX2 static void sfield__mix_dot_avx2(const sfield_field *f, const sfield__between *at,
                                                     const float *t, uint32_t n, float *rgb)
{
    const float *b = at->corner, w0 = at->inner, w1 = at->outer;
    const uint32_t begin = f->tone < 3 ? f->tone : 0, end = f->tone < 3 ? f->tone + 1 : 3;
    const size_t stride = f->h.stride, row = f->h.position_side * stride,
                 shell = 6 * f->h.position_side * row;
    const uint8_t *q = f->sample + at->base * stride + begin * n;
    const float *s0 = f->scale + at->group * stride + begin * n;
    const float *b0 = f->bias + at->group * stride + begin * n;
    const __m256 x0 = _mm256_set1_ps(b[0]), x1 = _mm256_set1_ps(b[1]), x2 = _mm256_set1_ps(b[2]),
                 x3 = _mm256_set1_ps(b[3]);
    uint32_t k, c;
    for (c = begin; c < end; c++) {
        __m256 sum = _mm256_setzero_ps(), a, e;
        __m128 four;
        for (k = 0; k < n; k += 8, q += 8, s0 += 8, b0 += 8) {
            a = _mm256_mul_ps(sfield__bytes8(q), x0), e = _mm256_mul_ps(sfield__bytes8(q + shell), x0);
            a = _mm256_fmadd_ps(sfield__bytes8(q + stride), x1, a);
            e = _mm256_fmadd_ps(sfield__bytes8(q + shell + stride), x1, e);
            a = _mm256_fmadd_ps(sfield__bytes8(q + row), x2, a);
            e = _mm256_fmadd_ps(sfield__bytes8(q + shell + row), x2, e);
            a = _mm256_fmadd_ps(sfield__bytes8(q + row + stride), x3, a);
            e = _mm256_fmadd_ps(sfield__bytes8(q + shell + row + stride), x3, e);
            a = _mm256_fmadd_ps(a, _mm256_loadu_ps(s0), _mm256_loadu_ps(b0));
            e = _mm256_fmadd_ps(e, _mm256_loadu_ps(s0 + stride), _mm256_loadu_ps(b0 + stride));
            a = _mm256_fmadd_ps(e, _mm256_set1_ps(w1), _mm256_mul_ps(a, _mm256_set1_ps(w0)));
            sum = _mm256_fmadd_ps(a, _mm256_loadu_ps(t + k), sum);
        }
        four = _mm_add_ps(_mm256_castps256_ps128(sum), _mm256_extractf128_ps(sum, 1));
        four = _mm_add_ps(four, _mm_movehl_ps(four, four));
        rgb[c] += _mm_cvtss_f32(_mm_add_ss(four, _mm_movehdup_ps(four)));
    }
}
#endif

/* Adds a source's dot products with T, of one channel where the others are multiples of it. */
static void sfield__add_source(const sfield__item *it, const float *sum, float *rgb)
{
    const sfield_field *f = it->e.source;
    uint32_t c;
    for (c = 0; c < 3; c++)
        rgb[c * SFIELD__LANES] += it->e.tint[c] * (f->tone < 3 ? f->ratio[c] * sum[f->tone] : sum[c]);
}

#if SFIELD__SIMD
/* Computes the dot products of a place in a source with T, lane by lane: T is transposed once, and the
   coefficients are never stored. */
static void sfield__shine_avx2(const sfield__tile *t, const sfield__item *it, const sfield__place *at,
                               const float *chain, float *rgb)
{
    const sfield_field *f = it->e.source;
    const uint32_t n = t->s->coefs;
    uint32_t l, k, before, after;
    float time = sfield__frames_at(f, it->e.time, &before, &after);
    for (k = 0; k < n; k += 8)
        for (l = 0; l < SFIELD__LANES; l += 8)
            sfield__transpose8_avx2(chain + k * SFIELD__LANES + l, SFIELD__LANES, t->rows + l * n + k, n);
    for (l = 0; l < t->lanes; l++) {
        float sum[3] = { 0, 0, 0 };
        sfield__between b = sfield__find_between(at, (int)l, 1 - time);
        b = sfield__between_of_frame(f, &b, before);
        sfield__mix_dot_avx2(f, &b, t->rows + l * n, n, sum);
        if (time > 0) {
            b = sfield__find_between(at, (int)l, time);
            b = sfield__between_of_frame(f, &b, after);
            sfield__mix_dot_avx2(f, &b, t->rows + l * n, n, sum);
        }
        sfield__add_source(it, sum, rgb + l);
    }
}
#endif

/* Does the same for the wanted lanes if they share samples, without transposing T. Returns 0, with nothing
   done, if they do not. */
static int sfield__shine_shared(const sfield__tile *t, const sfield__item *it, const sfield__place *at,
                                const float *chain, float *rgb)
{
    const sfield_field *f = it->e.source;
    const uint32_t n = t->s->coefs, shells = f->h.shells, every = f->tone < 3;
    const size_t samples = 6 * (size_t)f->h.position_side * f->h.position_side * shells;
    uint32_t group[SFIELD__LANES], frame[2], i;
    uint32_t k, c, l;
    uint32_t count = sfield__group_lanes(at, t->visible, group, t->s->simd);
    float sum[3][SFIELD__LANES] = { { 0 } }, weight[2][SFIELD__LANES], own[SFIELD__LANES];
    float time = sfield__frames_at(f, it->e.time, &frame[0], &frame[1]);
    for (l = 0; l < SFIELD__LANES; l++) {
        weight[0][l] = 1 - time;
        weight[1][l] = time;
    }
    for (i = 0; i < count; i++) {
        for (l = 0; !(group[i] >> l & 1);) l++;
        for (k = 0; k < (time > 0 ? 2u : 1u); k++) {
            sfield__select16(weight[k], SFIELD__LANES, group[i], own, t->s->simd);
            for (c = every ? f->tone : 0; c < (every ? f->tone + 1 : 3); c++) {
                sfield__eight e;
                sfield__load_eight(f, frame[k] * samples + (size_t)at->base[l],
                                   frame[k] * shells + (size_t)at->shell[l], c * n, n, &e, t->s->simd);
                sfield__dot_eight(&e, at, own, chain, sum[c], t->s->simd);
            }
        }
    }
    for (c = 0; c < 3 && count; c++)
        for (l = 0; l < SFIELD__LANES; l++)
            rgb[c * SFIELD__LANES + l] += it->e.tint[c] * (every ? f->ratio[c] * sum[f->tone][l] : sum[c][l]);
    return count != 0;
}

/* Adds T . source of light j to rgb, three channels. */
static void sfield__shine_light(const sfield__tile *t, uint32_t j, const float *chain, float *rgb)
{
    const sfield_scene *s = t->s;
    const sfield__item *it = &s->item[s->light[j]];
    const sfield_field *f = it->e.source;
    float local[48], *rows = t->rows;
    sfield__place at;
    uint32_t l, c, k;
    sfield__move_to_local(it, 1, t->p, local, s->simd);
    sfield__locate16(f, local, &at, s->simd);
    if (!it->identity) {
        sfield__rotate16(&s->rotation[s->light[j]], chain, t->turned, SFIELD__LANES, 1, s->simd);
        chain = t->turned;
    }
    if (s->coefs % 8 == 0 && sfield__shine_shared(t, it, &at, chain, rgb)) return;
#if SFIELD__SIMD
    if (s->simd && s->coefs % 8 == 0) {
        sfield__shine_avx2(t, it, &at, chain, rgb);
        return;
    }
#endif
    for (l = 0; l < SFIELD__LANES; l++)
        sfield__fetch_lane(f, &at, (int)l, it->e.time, f->h.stride, rows + l * f->h.stride, s->simd);
    for (l = 0; l < SFIELD__LANES; l++) {
        float sum[3] = { 0, 0, 0 };
        for (c = 0; c < 3; c++) {
            const float *row = rows + l * f->h.stride + c * s->planes;
            if (f->tone < 3 && c != f->tone) continue;
            for (k = 0; k < s->coefs; k++) sum[c] += row[k] * chain[k * SFIELD__LANES + l];
        }
        sfield__add_source(it, sum, rgb + l);
    }
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
            out[3 * (t->first + l) + c] = t->visible >> l & 1 ? rgb[c * SFIELD__LANES + l] * factor : 0.0f;
}

static void sfield__write_outputs(sfield__tile *t)
{
    const sfield_points *set = t->set;
    float rgb[3 * SFIELD__LANES];
    uint32_t l, n = t->s->coefs * SFIELD__LANES;
    const float *sky = t->t + (size_t)t->lights * (size_t)t->chains * n;
    if (set->rgb) {
        sfield__sum_lights(t, 0, rgb);
        sfield__store_rgb(t, rgb, 0.318309886f, set->rgb);
    }
    if (set->gloss) {
        if (t->chains == 2) sfield__sum_lights(t, 1, rgb);
        else memset(rgb, 0, sizeof rgb);
        sfield__store_rgb(t, rgb, 1, set->gloss);
    }
    for (l = 0; l < t->lanes && set->ambient; l++)
        set->ambient[t->first + l] = t->visible >> l & 1 ? sky[l] * 0.318309886f / sfield__y00 : 0.0f;
}
