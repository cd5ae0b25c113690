/* ---- estimator: samples and their weights ---- */

typedef struct lsamp__estimator { /* one point and one light */
    const lsamp_sample_desc *desc;
    lsamp__surface surface;
    lsamp__aim     aim;
    int            reachable;    /* light can reach the point, and the point is a receiver */
    int            split;        /* as in the paper, the two parts of the BRDF are integrated apart */
    float          light_share;  /* the share of samples that the light draws; the BRDF draws the others */
} lsamp__estimator;

/* Decides how many samples the light draws and how many the BRDF: the BRDF draws few if the light is smaller
   than the lobe, and the light draws few if the lobe is smaller. With q = (solid angle) (peak density), a
   share of q^3 / (8 + q^3) for the BRDF gave 0.29 of the noise that shares of one half gave (geometric mean
   over 54 pairs of light and material, 64 samples), and 0.68 of it under shadows; q / (1 + q) gave 0.52 and
   0.76. The shares are whole samples, so that stratified numbers are split without a remainder. */
static void lsamp__estimator_init(lsamp__estimator *e, const lsamp_sample_desc *desc,
                                  const lsamp_light *light)
{
    int unseen = lsamp__is_delta(light) || light->desc.kind == LSAMP_LIGHT_CALLBACK;
    int distant = light->desc.kind == LSAMP_LIGHT_ENVIRONMENT;
    float q;

    e->desc = desc;
    e->split = distant && desc->sampling == LSAMP_SAMPLING_PAPER;
    e->light_share = 1.0f;
    if (unseen || desc->sampling == LSAMP_SAMPLING_LIGHT || !e->reachable) return;
    if (desc->sampling == LSAMP_SAMPLING_BRDF) e->light_share = 0.0f;
    else if (desc->sampling == LSAMP_SAMPLING_PAPER)
        e->light_share = distant ? e->surface.diffuse_share : 1.0f;
    else if (distant) e->light_share = 0.5f;
    else {
        q = e->aim.solid * e->surface.peak;
        e->light_share = 8.0f / (8.0f + q * q * q);
        e->light_share =
            floorf(e->light_share * (float)desc->sample_count + 0.5f) / (float)desc->sample_count;
    }
}

/* Draws one sample and returns its weight times S. The first number decides by roulette between light and
   BRDF, and is then stretched again for the drawing. The densities of both techniques are summed in
   proportion, which is the one-sample form of the balance heuristic. */
static lsamp__v3 lsamp__estimate(const lsamp__estimator *e, const float *numbers, lsamp_emission *found)
{
    const lsamp__v3 zero = lsamp__v3_make(0.0f, 0.0f, 0.0f);
    const lsamp__surface *s = &e->surface;
    float u[3], c = e->light_share, pdf;
    int by_light = numbers[0] < c, hit;
    lsamp__v3 wi, f;
    lsamp__response r;

    u[0] = lsamp__clamp_unit(by_light ? numbers[0] / c : (numbers[0] - c) / (1.0f - c));
    u[1] = numbers[1];
    u[2] = numbers[2];
    if (by_light) {
        hit = lsamp__emitter_draw(&e->aim, u, found);
    } else {
        wi = lsamp__brdf_draw(s, e->split ? 0.0f : s->diffuse_share, u[0], u[1]);
        hit = wi.z > 0.0f && lsamp__aim_hit(&e->aim, lsamp__from_axes(s->t, s->b, s->n, wi), found);
    }
    if (!hit) {
        memset(found, 0, sizeof *found);
        return zero;
    }
    wi = lsamp__to_axes(s, lsamp__v3_load(found->direction));
    r = lsamp__brdf_response(s, wi);
    if (e->split) {
        f = by_light ? r.diffuse : r.specular;
        pdf = by_light ? c * found->pdf : (1.0f - c) * r.specular_pdf;
    } else {
        f = lsamp__v3_add(r.diffuse, r.specular);
        pdf = c * found->pdf + (1.0f - c) * lsamp__brdf_pdf(s, &r);
    }
    if (!(wi.z > 0.0f) || !(pdf > 0.0f)) return zero;
    f = lsamp__v3_scale(lsamp__v3_mul(f, lsamp__v3_load(found->radiance)), wi.z / pdf);
    return lsamp__v3_finite(f) ? f : zero;
}

#define LSAMP__SAMPLE_BLOCK 32u

/* Prefetches the rows, sums and texels that the light's samples of a block will read, one dependency at a
   time, since large maps do not fit into the cache. */
static void lsamp__environment_warm(const lsamp__estimator *e, float (*u)[3], uint32_t count)
{
    const lsamp_light *l = e->aim.light;
    uint32_t k, w = l->desc.width, h = l->desc.height;
    size_t at[LSAMP__SAMPLE_BLOCK];
    float unused;

    if (l->desc.kind != LSAMP_LIGHT_ENVIRONMENT || !(lsamp__cdf2_total(&l->cdf) > 0.0)) return;
    for (k = 0; k < count; k++) {
        uint32_t y = lsamp__invert_sums(l->cdf.rows, l->guide, h, u[k][1], &unused);
        at[k] = (size_t)y * w;
        if (!(u[k][0] < e->light_share)) continue;
        LSAMP__PREFETCH(l->guide + h + at[k] + lsamp__cell_of(u[k][0] / e->light_share, w));
    }
    for (k = 0; k < count; k++) {
        uint32_t x;
        if (!(u[k][0] < e->light_share)) continue;
        x = l->guide[h + at[k] + lsamp__cell_of(u[k][0] / e->light_share, w)];
        LSAMP__PREFETCH(l->cdf.sums + at[k] + at[k] / w + x);
        LSAMP__PREFETCH(l->desc.texels + (at[k] + x) * 3u);
    }
}

static const float *lsamp__vector_at(const float *base, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)base + (stride ? stride : 12u) * i);
}

static const lsamp_material *lsamp__material_at(const lsamp_points *p, size_t i)
{
    return (const lsamp_material *)(const void *)((const char *)p->materials + p->material_stride * i);
}

/* Says whether a vector is 0 0 0 or not finite, by which a point is no receiver. */
static int lsamp__is_none(const float *p)
{
    return (p[0] == 0.0f && p[1] == 0.0f && p[2] == 0.0f) || !lsamp__v3_finite(lsamp__v3_load(p));
}

/* Says whether point i is lit at all: its position and vectors are there and finite. */
static int lsamp__is_receiver(const lsamp_points *p, size_t i)
{
    return lsamp__v3_finite(lsamp__v3_load(lsamp__vector_at(p->positions, p->position_stride, i))) &&
           !lsamp__is_none(lsamp__vector_at(p->normals, p->normal_stride, i)) &&
           !(p->to_eye && lsamp__is_none(lsamp__vector_at(p->to_eye, p->to_eye_stride, i))) &&
           !(p->tangents && lsamp__is_none(lsamp__vector_at(p->tangents, p->tangent_stride, i)));
}

/* Returns LSAMP_ERR_INPUT, and logs so, if vector i of an array is not unit. */
static lsamp_result lsamp__unit_check(const char *array, const float *vectors, size_t stride, size_t i,
                                      const lsamp__logger *log)
{
    const float *p = lsamp__vector_at(vectors, stride, i);
    if (lsamp__is_unit(p)) return LSAMP_OK;
    lsamp__log_element(log, array, i, "has the length", (double)lsamp__v3_length(lsamp__v3_load(p)),
                       "1 (0.97..1.03), or 0");
    return LSAMP_ERR_INPUT;
}

static lsamp_result lsamp__stride_check(const char *field, size_t stride, const lsamp__logger *log)
{
    if (lsamp__stride_valid(stride, 12)) return LSAMP_OK;
    lsamp__log_value(log, field, (double)stride, "0 or a multiple of 4 from 12 on");
    return LSAMP_ERR_ARGUMENT;
}

/* Checks the arrays of points, but not what is in them. */
static lsamp_result lsamp__arrays_check(const lsamp_points *p, const lsamp__logger *log)
{
    lsamp_result result = LSAMP_OK;

    if (!p->positions) return lsamp__refuse(log, LSAMP_ERR_ARGUMENT, "points.positions", "is NULL");
    if (!p->normals) return lsamp__refuse(log, LSAMP_ERR_ARGUMENT, "points.normals", "is NULL");
    if (!p->materials) return lsamp__refuse(log, LSAMP_ERR_ARGUMENT, "points.materials", "is NULL");
    if (result == LSAMP_OK) result = lsamp__stride_check("points.position_stride", p->position_stride, log);
    if (result == LSAMP_OK) result = lsamp__stride_check("points.normal_stride", p->normal_stride, log);
    if (result == LSAMP_OK) result = lsamp__stride_check("points.to_eye_stride", p->to_eye_stride, log);
    if (result == LSAMP_OK) result = lsamp__stride_check("points.tangent_stride", p->tangent_stride, log);
    if (result == LSAMP_OK && (p->material_stride % sizeof(void *) ||
                               (p->material_stride && p->material_stride < sizeof(lsamp_material)))) {
        lsamp__log_value(log, "points.material_stride", (double)p->material_stride,
                         "0, or sizeof(lsamp_material) or above, a multiple of sizeof(void *)");
        result = LSAMP_ERR_ARGUMENT;
    }
    return result;
}

static lsamp_result lsamp__points_check(const lsamp_points *p, const lsamp__logger *log)
{
    lsamp_result result = LSAMP_OK;
    lsamp__fault fault;
    size_t i;

    if (p->count == 0) return LSAMP_OK;
    result = lsamp__arrays_check(p, log);
    for (i = 0; i < p->count && result == LSAMP_OK; i++) {
        if ((i == 0 || p->material_stride) && !lsamp__material_valid(lsamp__material_at(p, i), &fault)) {
            lsamp__log_element(log, "points.materials", i, fault.field, (double)fault.value, fault.wanted);
            return LSAMP_ERR_INPUT;
        }
        if (!lsamp__is_receiver(p, i)) continue;
        result = lsamp__unit_check("points.normals", p->normals, p->normal_stride, i, log);
        if (result == LSAMP_OK && p->to_eye)
            result = lsamp__unit_check("points.to_eye", p->to_eye, p->to_eye_stride, i, log);
        if (result == LSAMP_OK && p->tangents)
            result = lsamp__unit_check("points.tangents", p->tangents, p->tangent_stride, i, log);
    }
    return result;
}

/* Draws all samples of one point, the first of which has the number at. Returns how many have a weight. */
static size_t lsamp__sample_point(const lsamp__estimator *e, uint32_t pixel, const lsamp_samples *out,
                                  size_t at)
{
    uint32_t count = e->desc->sample_count, k, b, block;
    int third = e->aim.light->desc.kind == LSAMP_LIGHT_CALLBACK;
    float u[LSAMP__SAMPLE_BLOCK][3], scale = 1.0f / (float)count;
    size_t useful = 0;

    for (k = 0; k < count; k += block) {
        block = count - k < LSAMP__SAMPLE_BLOCK ? count - k : LSAMP__SAMPLE_BLOCK;
        if (e->reachable) {
            for (b = 0; b < block; b++) lsamp__random_numbers(e->desc, pixel, k + b, third, u[b]);
            lsamp__environment_warm(e, u, block);
        }
        for (b = 0; b < block; b++, at++) {
            lsamp__v3 weight = lsamp__v3_make(0.0f, 0.0f, 0.0f);
            lsamp_emission found;

            memset(&found, 0, sizeof found);
            if (e->reachable) weight = lsamp__v3_scale(lsamp__estimate(e, u[b], &found), scale);
            if (!(found.pdf > 0.0f)) {
                lsamp__v3_store(found.direction, e->surface.n);
                found.distance = LSAMP_INFINITY;
            }
            useful += weight.x + weight.y + weight.z > 0.0f;
            memcpy(out->directions + at * 3u, found.direction, sizeof found.direction);
            out->distances[at] = found.distance;
            if (out->coords) memcpy(out->coords + at * 3u, found.coords, sizeof found.coords);
            lsamp__v3_store(out->weights + at * 3u, weight);
        }
    }
    return useful;
}

LSAMP_DEF lsamp_result lsamp_sample(const lsamp_sample_desc *desc, const lsamp_light *light,
                                    const lsamp_points *points, const lsamp_samples *out, size_t *useful)
{
    lsamp_result result;
    lsamp__logger log;
    size_t i, n = 0, total;

    if (!desc) return LSAMP_ERR_ARGUMENT;
    log = lsamp__logger_of(&desc->system, "lsamp_sample");
    if (!light) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "light", "is NULL");
    if (!points) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "points", "is NULL");
    if (!out) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "out", "is NULL");
    if (!out->directions) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "out.directions", "is NULL");
    if (!out->distances) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "out.distances", "is NULL");
    if (!out->weights) return lsamp__refuse(&log, LSAMP_ERR_ARGUMENT, "out.weights", "is NULL");
    if (desc->sample_count == 0 || desc->sample_count > 65536u) {
        lsamp__log_value(&log, "desc.sample_count", (double)desc->sample_count, "1..65536");
        return LSAMP_ERR_DESC;
    }
    if ((unsigned)desc->sampling >= (unsigned)LSAMP_SAMPLING_COUNT) {
        lsamp__log_value(&log, "desc.sampling", (double)desc->sampling, "a LSAMP_SAMPLING_...");
        return LSAMP_ERR_DESC;
    }
    if (!lsamp__mul_size(points->count, (size_t)desc->sample_count * 12u, &total)) {
        lsamp__log_value(&log, "points.count", (double)points->count, "less: out does not fit a size_t");
        return LSAMP_ERR_LIMIT;
    }
    result = lsamp__points_check(points, &log);
    if (result != LSAMP_OK) return result;
    for (i = 0; i < points->count; i++) {
        lsamp__estimator e;
        const float *normal = lsamp__vector_at(points->normals, points->normal_stride, i);
        const float *view =
            points->to_eye ? lsamp__vector_at(points->to_eye, points->to_eye_stride, i) : normal;
        const float *tangent =
            points->tangents ? lsamp__vector_at(points->tangents, points->tangent_stride, i) : NULL;
        const float *p = lsamp__vector_at(points->positions, points->position_stride, i);

        if (!lsamp__is_receiver(points, i)) {
            memset(&e, 0, sizeof e);
            e.aim.light = light;
        } else {
            lsamp__surface_init(&e.surface, lsamp__material_at(points, i), lsamp__v3_load(normal), tangent,
                                lsamp__v3_load(view));
            e.reachable = lsamp__aim_at(&e.aim, light, lsamp__v3_load(p)) && !e.surface.black;
        }
        lsamp__estimator_init(&e, desc, light);
        n +=
            lsamp__sample_point(&e, points->pixels ? points->pixels[i] : (uint32_t)i, out,
                                i * desc->sample_count);
    }
    if (useful) *useful = n;
    return LSAMP_OK;
}

/* ---- accumulate: sums over samples and frames ---- */

LSAMP_DEF lsamp_result lsamp_accumulate(size_t count, uint32_t sample_count, const float *weights,
                                        const float *visible, float *radiance, size_t radiance_stride)
{
    size_t i, c, at = 0;
    uint32_t k;

    if (sample_count == 0 || (count && (!weights || !radiance)) || !lsamp__stride_valid(radiance_stride, 12))
        return LSAMP_ERR_ARGUMENT;
    for (i = 0; i < count; i++) {
        float *out = (float *)(void *)((char *)radiance + (radiance_stride ? radiance_stride : 12u) * i);
        double sum[3] = { 0.0, 0.0, 0.0 };

        for (k = 0; k < sample_count; k++, at++) {
            const float *w = weights + at * 3u;
            double v;
            if (w[0] == 0.0f && w[1] == 0.0f && w[2] == 0.0f) continue;
            v = visible ? (double)visible[at] : 1.0;
            if (!(v > 0.0)) continue;       /* also of COHSM_REFUSED */
            for (c = 0; c < 3; c++) sum[c] += v * (double)w[c];
        }
        for (c = 0; c < 3; c++) out[c] += (float)sum[c];
    }
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_progressive_reset(lsamp_progressive *p)
{
    size_t i;
    if (!p || (p->count && !p->sums)) return LSAMP_ERR_ARGUMENT;
    for (i = 0; i < p->count; i++) p->sums[i] = 0.0;
    p->frame_count = 0;
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_progressive_add(lsamp_progressive *p, const float *frame)
{
    size_t i;
    if (!p || (p->count && (!p->sums || !frame))) return LSAMP_ERR_ARGUMENT;
    if (p->frame_count == UINT32_MAX) return LSAMP_ERR_LIMIT;
    for (i = 0; i < p->count; i++) p->sums[i] += (double)frame[i];
    p->frame_count++;
    return LSAMP_OK;
}

LSAMP_DEF lsamp_result lsamp_progressive_mean(const lsamp_progressive *p, float *mean)
{
    size_t i;
    if (!p || (p->count && (!p->sums || !mean))) return LSAMP_ERR_ARGUMENT;
    if (p->frame_count == 0) return LSAMP_ERR_ORDER;
    for (i = 0; i < p->count; i++) mean[i] = (float)(p->sums[i] / (double)p->frame_count);
    return LSAMP_OK;
}
