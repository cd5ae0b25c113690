/* ---- importance: what a pVPL does to the picture (paper 4.1, 4.2) ---- */

typedef struct ism__choice {
    ism_maps         *m;
    const ism__job   *job;
    float             extent;       /* diagonal of the receivers' box */
    size_t            source;       /* the source that is weighed; what follows is its own */
    float *lum, *effect, *out;      /* flux; effect on the picture, of which by_mean says how it is a mean;
                                       the effect blurred, as a number that goes as light does */
    int               by_mean;      /* the effect is the mean; 0: the mean square, of which the root counts */
    uint32_t          seed;
    float             blur_radius;
    float             from, to;     /* share of the call's progress */
} ism__choice;

/* Returns how much light a unit of flux at q adds to a receiver at p: cos cos / d^2, bounded at distances
   below a hundredth of the picture's extent, and for directions the receiver's cosine. Lobes are taken for
   light that is equal all round, since an importance need not be exact. */
static float ism__unit_flux_light(const ism_source *s, ism__v3 q, ism__v3 n, ism__v3 p, ism__v3 pn,
                                  float extent)
{
    ism__v3 d;
    float d2, a, b;
    if (s->kind == ISM_SOURCE_DIRECTIONS) {
        a = ism__v3_dot(pn, q);
        return a > 0.0f ? a : 0.0f;
    }
    d = ism__v3_sub(q, p);
    d2 = ism__v3_dot(d, d) + 1e-4f * extent * extent + 1e-30f;
    a = ism__v3_dot(pn, d);
    b = s->lobes ? sqrtf(d2) : -ism__v3_dot(n, d);
    return a > 0.0f && b > 0.0f ? a * b / (d2 * d2) : 0.0f;
}

/* Writes the place of a world position in pixels. Returns 0 if that place is at infinity or unknown. A
   position behind the camera has the mirrored place, as in paper 4.2. */
static int ism__to_pixel(const ism__view *view, ism__v3 p, float *x, float *y)
{
    const float *m = view->points->world_to_clip;
    float cx = m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12],
          cy = m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13];
    float w = m[3] * p.x + m[7] * p.y + m[11] * p.z + m[15];
    float lx, ly;
    if (!(fabsf(w) > 1e-20f)) return 0;
    lx = cx / w;
    ly = cy / w;
    if (!(fabsf(lx) < 8.0f && fabsf(ly) < 8.0f)) return 0;
    *x = (0.5f * lx + 0.5f) * (float)view->width;
    *y = (view->points->rows == ISM_ROWS_TOP_FIRST ? 0.5f - 0.5f * ly : 0.5f * ly + 0.5f) *
         (float)view->height;
    return 1;
}

/* Returns an estimate of the effect of one pVPL on the picture, by a jittered grid of receivers. Every other
   sample, as on a chessboard, is guided: its density falls as min(1, (r0 / r)^2) about the pVPL's own place.
   Guided and other samples are weighted by the balance heuristic, so that no place is forgotten. In an even
   grid rows and columns have as many of either kind, and guided samples take their numbers from their cells;
   in an odd grid they have numbers of their own, in steps of radius and of the golden ratio. */
static float ism__estimate_effect(const ism__choice *c, const ism_source *s, size_t i)
{
    const ism__view *view = &c->job->view;
    uint32_t grid = c->m->desc.view_grid_side, k, count = grid * grid;
    uint32_t w = view->width, h = view->height;
    ism__v3 q = ism__v3_load(ism__at(s->positions, s->position_stride, i)), n = q, p, pn;
    float cx = 0.0f, cy = 0.0f, r0 = 0.05f * (float)(w > h ? w : h);
    float reach = (float)w + (float)h, sum = 0.0f;
    uint32_t turn = ism__hash_combine(c->seed, (uint32_t)i * 256u + 255u), rank = 0;
    float inner, norm, uniform = 1.0f / ((float)w * (float)h), share = (float)(count / 2u) / (float)count;
    int guided = c->m->desc.importance == ISM_IMPORTANCE_GUIDED ||
                 c->m->desc.importance == ISM_IMPORTANCE_GUIDED_MEAN;
    guided = guided && s->kind != ISM_SOURCE_DIRECTIONS && h > 1u && count > 1u && r0 >= 1.0f;
    guided = guided && ism__to_pixel(view, q, &cx, &cy) && reach > r0;
    inner = 1.0f / (1.0f + 2.0f * ism__log(reach / r0));    /* share of the disc r < r0 */
    norm = inner / (ISM__PI * r0 * r0);                     /* density inside it */
    if (s->kind != ISM_SOURCE_DIRECTIONS) n = ism__v3_load(ism__at(s->normals, s->normal_stride, i));
    for (k = 0; k < count; k++) {
        uint32_t hash = ism__hash_combine(c->seed, (uint32_t)i * 256u + k);
        float u = ((float)(k % grid) + ism__to_unit(hash)) / (float)grid;
        float v = ((float)(k / grid) + ism__to_unit(ism__hash32(hash))) / (float)grid;
        float x = u * (float)w, y = v * (float)h, density = uniform;
        if (guided && ((k % grid + k / grid) & 1u)) {
            float r, sine, cosine;
            if (grid & 1u) {
                u = ((float)rank + ism__to_unit(hash)) / (float)(count / 2u);
                v = ism__to_unit(turn + rank++ * 2654435769u);
            }
            r = u < inner ? r0 * sqrtf(u / inner) : r0 * ism__pow(reach / r0, (u - inner) / (1.0f - inner));
            ism__sincos(6.28318531f * v, &sine, &cosine);
            x = cx + r * cosine;
            y = cy + r * sine;
        }
        if (!(x >= 0.0f && y >= 0.0f && x < (float)w && y < (float)h)) continue;
        if (guided) {
            float r2 = (x - cx) * (x - cx) + (y - cy) * (y - cy);
            density = (1.0f - share) * uniform + share * norm * (r2 > r0 * r0 ? r0 * r0 / r2 : 1.0f);
        }
        if (ism__receiver(view, (size_t)ism__texel_of(y / (float)h, h) * w + ism__texel_of(x / (float)w, w),
                          &p, &pn)) {
            float e = ism__unit_flux_light(s, q, n, p, pn, c->extent);
            sum += (c->by_mean ? e : e * e) * (uniform / density);
        }
    }
    /* The root of a mean square is taken after the blur. The picture's squared error is least if VPLs are
       chosen in proportion to that root, not to the mean. */
    return sum / (float)count;
}

static void ism__estimate_task(void *context, size_t row)
{
    ism__choice *c = (ism__choice *)context;
    const ism_source *s = &c->job->frame->sources[c->source];
    size_t x;
    for (x = 0; x < s->width; x++) {
        size_t i = row * s->width + x;
        c->effect[i] = c->lum[i] > 0.0f ? ism__estimate_effect(c, s, i) : 0.0f;
    }
}

/* Returns what a blurred effect counts in the choice. */
static float ism__effect_of(const ism__choice *c, float effect)
{
    return c->by_mean ? effect : sqrtf(effect);
}

/* Blurs the effects of a row of texels over neighbours on the same surface (paper 6.5), and takes roots of
   mean squares. Fluxes are not blurred. */
static void ism__blur_task(void *context, size_t row)
{
    ism__choice *c = (ism__choice *)context;
    const ism_source *s = &c->job->frame->sources[c->source];
    int radius = (int)c->blur_radius, x, y;
    int w = (int)s->width, h = (int)s->height;
    for (x = 0; x < w; x++) {
        size_t i = row * s->width + (size_t)x;
        ism__v3 q = ism__v3_load(ism__at(s->positions, s->position_stride, i));
        ism__v3 n = ism__v3_load(ism__at(s->normals, s->normal_stride, i));
        float sum = 0.0f, weights = 0.0f;
        int y0 = (int)row - radius, y1 = (int)row + radius, x0 = x - radius;
        int x1 = x + radius, k;
        c->out[i] = 0.0f;
        if (!(c->lum[i] > 0.0f)) continue;
        for (y = y0 > 0 ? y0 : 0; y <= y1 && y < h; y++)
            for (k = x0 > 0 ? x0 : 0; k <= x1 && k < w; k++) {
                size_t j = (size_t)y * s->width + (size_t)k;
                ism__v3 d;
                float weight;
                if (!(c->lum[j] > 0.0f)) continue;
                d = ism__v3_sub(ism__v3_load(ism__at(s->positions, s->position_stride, j)), q);
                weight = ism__v3_dot(n, ism__v3_load(ism__at(s->normals, s->normal_stride, j)));
                if (weight <= 0.5f || fabsf(ism__v3_dot(n, d)) > 0.3f * ism__v3_length(d)) continue;
                sum += weight * c->effect[j];
                weights += weight;
            }
        c->out[i] = ism__effect_of(c, weights > 0.0f ? sum / weights : c->effect[i]);
    }
}

/* Returns the diagonal of the receivers' box. */
static float ism__extent(const ism__view *view)
{
    ism__v3 lo = ism__v3_make(1e30f, 1e30f, 1e30f), hi = ism__v3_make(-1e30f, -1e30f, -1e30f), p, n;
    size_t i, count = view->points->count, step = count / 65536u + 1u;
    for (i = 0; i < count; i += step)
        if (ism__receiver(view, i, &p, &n)) {
            lo = ism__v3_min(lo, p);
            hi = ism__v3_max(hi, p);
        }
    return lo.x <= hi.x ? ism__v3_length(ism__v3_sub(hi, lo)) : 0.0f;
}

/* Writes the fluxes of one source into c->lum, and into c->out the effect of a unit of each on the picture.
   */
static ism_result ism__weigh_source(ism__choice *c, const ism_source *s, double *flux)
{
    ism_maps *m = c->m;
    size_t count = (size_t)s->width * s->height, i;
    const char *wrong = NULL;
    float share = c->to - c->from;
    uint32_t radius;
    int bad;
    *flux = 0.0;
    for (i = 0; i < count; i++) {
        c->lum[i] = ism__pvpl_luminance(s, i, &bad, &wrong);
        if (wrong) return ism__not_unit(&c->job->log, s, c->source, i, wrong);
        m->stats.bad_pvpls += (uint64_t)bad;
        *flux += (double)c->lum[i];
        if (s->kind != ISM_SOURCE_DIRECTIONS && c->lum[i] > 0.0f) {
            const float *f = ism__at(s->fluxes, s->flux_stride, i);
            int k;
            for (k = 0; k < 3; k++) m->stats.flux[k] += (double)f[k];
        }
    }
    for (i = 0; i < count; i++) c->out[i] = 0.0f;
    if (m->desc.importance == ISM_IMPORTANCE_FLUX || !(*flux > 0.0)) return ISM_OK;
    if (!ism__run(m, &c->job->part, c->from, c->from + 0.8f * share, s->height, ism__estimate_task, c))
        return ISM_ERR_CANCELLED;
    radius = m->desc.blur_radius > 0 ? (uint32_t)m->desc.blur_radius : 0;
    if (!m->desc.blur_radius) {
        radius = (uint32_t)(0.05f * (float)(s->width < s->height ? s->width : s->height));
        radius = radius < 6u ? radius : 6u;
    }
    c->blur_radius = (float)radius;
    if (s->scattered || s->kind == ISM_SOURCE_DIRECTIONS || !radius)
        for (i = 0; i < count; i++) c->out[i] = ism__effect_of(c, c->effect[i]);
    else if (!ism__run(m, &c->job->part, c->from + 0.8f * share, c->to, s->height, ism__blur_task, c))
        return ISM_ERR_CANCELLED;
    return ISM_OK;
}

/* Writes the importances into c->out: flux x (effect + a constant, so that no texel is forgotten). The
   constant makes choice by flux alone a given share of all sources together: if it were a share of each
   source, one with a few great effects would leave the others nothing. Fluxes of directions are irradiances,
   and have a constant of their own. */
static void ism__add_shares(ism__choice *c, const ism__source_of *of)
{
    const ism_frame *f = c->job->frame;
    double share = (double)c->m->desc.flux_share, flux[2] = { 0.0, 0.0 }, total = 0.0;
    double kinds, least[2];
    size_t s, i = 0, end;
    for (s = 0; s < f->source_count; s++) {
        flux[f->sources[s].kind == ISM_SOURCE_DIRECTIONS] += of[s].flux;
        for (end = i + (size_t)f->sources[s].width * f->sources[s].height; i < end; i++)
            total += (double)(c->lum[i] * c->out[i]);
    }
    kinds = flux[0] > 0.0 && flux[1] > 0.0 ? 2.0 : 1.0;
    for (s = 0; s < 2; s++)
        least[s] =
            total > 0.0 && flux[s] > 0.0 ? total / kinds / flux[s] * share / (1.0 - 0.999 * share) : 1.0;
    for (s = i = 0; s < f->source_count; s++) {
        float lowest = (float)least[f->sources[s].kind == ISM_SOURCE_DIRECTIONS];
        for (end = i + (size_t)f->sources[s].width * f->sources[s].height; i < end; i++)
            c->out[i] = c->lum[i] * (c->out[i] + lowest);
    }
}
