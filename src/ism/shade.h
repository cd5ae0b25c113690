/* ---- shade: all lights at all receivers (paper 6.2) ---- */

/* Adds to out, times pi, the light of all near points, also in interleaved pictures: only a class, scaled up,
   would make white specks where a pixel has few neighbours on its surface to be blurred with. */
static void ism__shade_near(const ism__shade_work *w, const ism__pixel *px, float out[3], double lost[2])
{
    const ism_near_point *points = (const ism_near_point *)w->m->near_points.data;
    const float *sphere = (const float *)w->m->near_blocks.data;
    uint32_t n = w->m->near_count, first;
    uint32_t i, k, list[ISM__CHUNK];
    float kernels[ISM__CHUNK], plain[ISM__CHUNK], visible[ISM__CHUNK], sum[3] = { 0.0f, 0.0f, 0.0f };
    float part = 1.0f / (float)(w->interleave * w->interleave);    /* what is lost counts as of one class */
    for (first = 0; first < n; first += ISM__NEAR_BLOCK, sphere += 4) {
        ism__v3 d = ism__v3_sub(ism__v3_load(sphere), px->p);
        uint32_t end = n - first < ISM__NEAR_BLOCK ? n : first + ISM__NEAR_BLOCK, used = 0;
        if (!(ism__v3_dot(d, d) < sphere[3] * sphere[3])) continue;
        for (i = first; i < end; i++) {
            float p = 0.0f, kernel = ism__near_kernel(&points[i], px, &p);
            if (!(kernel > 0.0f)) continue;
            kernels[used] = kernel;
            plain[used] = p;
            list[used++] = i;
        }
        if (used) ism__near_visibilities(w, px, list, used, visible);
        for (i = 0; i < used; i++) {
            const float *flux = points[list[i]].flux;
            float c = kernels[i] * visible[i], l = ism__luminance(flux) * visible[i] * part;
            for (k = 0; k < 3u; k++) sum[k] += c * flux[k];
            if (plain[i] > kernels[i]) lost[0] += (double)((plain[i] - kernels[i]) * l);
            lost[1] += (double)((plain[i] > kernels[i] ? plain[i] : kernels[i]) * l);
        }
    }
    for (k = 0; k < 3u; k++) out[k] += sum[k];
}

/* Writes the irradiance of one pixel by the VPLs of its class, times the number of classes, so that the mean
   over classes is the sum over all VPLs. skip: a flag for each place in `order`, or NULL. */
static void ism__shade_pixel(const ism__shade_work *w, const ism__pixel *px, uint32_t class_index,
                             const uint8_t *skip, float out[3], double lost[2])
{
    uint32_t first = w->class_first[class_index], end = w->class_first[class_index + 1u], at;
    uint32_t i, k;
    float kernels[ISM__CHUNK], plain[ISM__CHUNK], visible[ISM__CHUNK], sum[3] = { 0.0f, 0.0f, 0.0f };
    float mean = w->s.near_mode == ISM_NEAR_CLAMP_MEAN ? ism__mean_light(w, px, first, end) : 0.0f;
    uint32_t list[ISM__CHUNK];
    for (at = first; at < end; at += ISM__CHUNK) {
        uint32_t count = end - at < ISM__CHUNK ? end - at : ISM__CHUNK, used = 0;
        ism__kernels(w, px, at, count, kernels);
        for (i = 0; i < count; i++) {
            const ism_vpl *v = &w->m->vpls[w->order[at + i]];
            float k0 = kernels[i], all = k0;
            if (skip && skip[at + i]) continue;
            if (!(k0 > 0.0f) && !v->directional && v->exponent == 1.0f) continue;
            k0 = ism__kernel(w, v, &w->axes[at + i], px, k0, &all);
            if (w->s.near_mode == ISM_NEAR_CLAMP_MEAN) {
                float most = w->s.clamp * mean, l = ism__luminance(v->flux);
                if (k0 * l > most) k0 = most / l;
            }
            if (!(k0 > 0.0f)) continue;
            kernels[used] = k0;
            plain[used] = all;
            list[used++] = at + i;
        }
        ism__visibilities(w, px, list, used, visible);
        for (i = 0; i < used; i++) {
            const ism_vpl *v = &w->m->vpls[w->order[list[i]]];
            float c = kernels[i] * visible[i], l = ism__luminance(v->flux) * visible[i];
            for (k = 0; k < 3u; k++) sum[k] += c * v->flux[k];
            if (plain[i] > kernels[i]) lost[0] += (double)((plain[i] - kernels[i]) * l);
            lost[1] += (double)((plain[i] > kernels[i] ? plain[i] : kernels[i]) * l);
        }
    }
    for (k = 0; k < 3u; k++) sum[k] *= (float)(w->interleave * w->interleave);
#ifndef ISM_WITHOUT_NEAR_POINTS
    if (w->s.near_mode == ISM_NEAR_GATHER) ism__shade_near(w, px, sum, lost);
#endif
    for (k = 0; k < 3u; k++) out[k] = sum[k] * (1.0f / ISM__PI);
}

static void ism__shade_task(void *context, size_t index)
{
    const ism__shade_work *w = (const ism__shade_work *)context;
    const ism__view *view = w->view;
    uint32_t bx = (uint32_t)(index % w->blocks_x) * ISM__BLOCK,
             by = (uint32_t)(index / w->blocks_x) * ISM__BLOCK, x, y;
    const uint8_t *skip = NULL;
    double *lost = w->lost + 4u * index;
#ifndef ISM_WITHOUT_CULLING
    uint8_t flags[16384];
#endif
    lost[0] = lost[1] = lost[2] = lost[3] = 0.0;
#ifndef ISM_WITHOUT_CULLING
    if (w->s.cull) {
        ism__cull(w, bx, by, flags, lost + 2);
        skip = flags;
    }
#endif
    for (y = by; y < by + ISM__BLOCK && y < view->height; y++)
        for (x = bx; x < bx + ISM__BLOCK && x < view->width; x++) {
            size_t i = (size_t)y * view->width + x;
            float *out = w->light + 3u * i;
            ism__pixel px;
            out[0] = out[1] = out[2] = 0.0f;
            if (!ism__receiver(view, i, &px.p, &px.n)) continue;
            px.ng = ism__geometric_normal(view, i, px.n);
            ism__shade_pixel(w, &px, (y % w->interleave) * w->interleave + x % w->interleave, skip, out,
                             lost);
        }
}

/* Sorts VPLs by their classes. A class is every interleave^2-th VPL of the sequence, and so spread evenly. */
static void ism__sort_classes(const ism_maps *m, uint32_t classes, uint32_t *order, uint32_t *class_first)
{
    uint32_t c, v, k = 0;
    for (c = 0; c < classes; c++) {
        class_first[c] = k;
        for (v = c; v < m->vpl_count; v += classes) order[k++] = v;
    }
    class_first[classes] = k;
}

/* Logs that a field of a desc is out of range, and returns ISM_ERR_DESC. */
static ism_result ism__bad_field(const ism__logger *log, const char *name, double value, const char *wanted)
{
    ism__log_value(log, name, value, wanted);
    return ISM_ERR_DESC;
}

static ism_result ism__check_shading(const ism_maps *m, const ism__job *job, const ism_shading *s)
{
    const ism__logger *log = &job->log;
#ifdef ISM_WITHOUT_INTERLEAVED
    if (s->interleave > 1u)
        return ism__bad_field(log, "shading.interleave", (double)s->interleave,
                              "0 or 1 in a header that was joined without interleaved shading");
#endif
    if (s->interleave > 8u || s->interleave == 3u || (s->interleave > 4u && s->interleave < 8u))
        return ism__bad_field(log, "shading.interleave", (double)s->interleave, "0, 1, 2, 4 or 8");
    if (s->interleave > 1u && job->view.height == 1u)
        return ism__bad_field(log, "shading.interleave", (double)s->interleave,
                              "0 or 1 where receivers are a list");
    if (s->near_mode < ISM_NEAR_DEFAULT || s->near_mode >= ISM_NEAR_COUNT)
        return ism__bad_field(log, "shading.near_mode", (double)s->near_mode, "a value of ism_near");
    if (!(s->bias < 1.0f)) return ism__bad_field(log, "shading.bias", (double)s->bias, "below 1");
    if (!(s->clamp >= 0.0f) || !ism__finite(s->clamp))
        return ism__bad_field(log, "shading.clamp", (double)s->clamp, "0 or above 0");
    if (!m->chosen) return ism__too_early(log, "maps", "have no VPLs: call ism_choose before");
    if (!m->built && !s->no_maps && !s->visible_fn && m->vpl_count)
        return ism__too_early(log, "maps", "are not drawn: call ism_build before");
    return ISM_OK;
}

/* Returns settings with defaults in place of zeros. */
static ism_shading ism__resolve_shading(const ism_shading *s)
{
    ism_shading out = *s;
    if (out.near_mode == ISM_NEAR_DEFAULT) out.near_mode = ISM_NEAR_GATHER;
    if (!(out.clamp > 0.0f)) out.clamp = 1.0f;
    if (!out.interleave) out.interleave = 1u;
    out.bias = ism__bias_of(out.bias);
    return out;
}

/* Copies what shading reads of VPLs into arrays. */
static void ism__fill_fields(const ism_maps *m, const uint32_t *order, float *fields,
                             ism__orientation *axes)
{
    size_t n = m->vpl_count, i;
    for (i = 0; i < n; i++) {
        const ism_vpl *v = &m->vpls[order[i]];
        int k;
        for (k = 0; k < 3; k++) {
            fields[(size_t)k * n + i] = v->position[k];
            fields[(size_t)(k + 3) * n + i] = v->normal[k];
        }
        axes[i] = ism__vpl_axes(m, v);
    }
}

/* Writes results: irradiances, times albedo / pi if the receivers have albedos. */
static void ism__reflect(const ism__view *view, const float *light, float *out)
{
    size_t i, count = view->points->count, k;
    for (i = 0; i < count; i++)
        for (k = 0; k < 3u; k++) {
            float e = light[3u * i + k];
            if (view->points->albedos) {
                float a = ism__at(view->points->albedos, view->points->albedo_stride, i)[k];
                e = ism__finite(a) && a > 0.0f ? e * a * (1.0f / ISM__PI) : 0.0f;
            }
            out[3u * i + k] = e;
        }
}

/* Adds up what the blocks counted. */
static void ism__sum_lost(const ism__shade_work *w, size_t blocks, ism_stats *stats)
{
    double lost = 0.0, all = 0.0, culled = 0.0, pairs = 0.0;
    size_t i;
    for (i = 0; i < blocks; i++) {
        lost += w->lost[4u * i];
        all += w->lost[4u * i + 1u];
        culled += w->lost[4u * i + 2u];
        pairs += w->lost[4u * i + 3u];
    }
    stats->lost_energy = all > 0.0 ? lost / all : 0.0;
    stats->culled = pairs > 0.0 ? culled / pairs : 0.0;
}

/* Places the arrays in the memory of one call: doubles first, then those that need less alignment. */
static void ism__lay_out_shading(ism__shade_work *w, char *memory, size_t pixels, size_t blocks)
{
    const ism_maps *m = w->m;
    size_t n = m->vpl_count;
    double *lost = (double *)(void *)memory;
    ism__orientation *axes = (ism__orientation *)(void *)(lost + 4u * blocks);
    float *fields = (float *)(void *)(axes + n), *light = fields + n * ISM__FIELDS;
    uint32_t *order = (uint32_t *)(void *)(light + pixels * 3u * (w->interleave > 1u ? 2u : 1u));
    ism__sort_classes(m, w->interleave * w->interleave, order, order + n);
    ism__fill_fields(m, order, fields, axes);
    w->lost = lost;
    w->axes = axes;
    w->fields = fields;
    w->light = light;
    w->blurred = light + pixels * 3u;
    w->order = order;
    w->class_first = order + n;
}

static ism_result ism__shade(const ism_maps *m, const ism__job *job, const ism_shading *shading, float *out,
                             ism_stats *stats)
{
    const ism__view *view = &job->view;
    ism__shade_work w;
    size_t pixels = view->points->count, blocks, n = m->vpl_count;
    size_t floats, size;
    char *memory;
    int whole;
    ism_result result = ism__check_shading(m, job, shading);
    if (result != ISM_OK) return result;
    memset(&w, 0, sizeof w);
    w.m = m;
    w.view = view;
    w.s = ism__resolve_shading(shading);
    w.interleave = w.s.interleave;
    w.blocks_x = (view->width + ISM__BLOCK - 1u) / ISM__BLOCK;
    blocks = (size_t)w.blocks_x * ((view->height + ISM__BLOCK - 1u) / ISM__BLOCK);
    floats = pixels * 3u * (w.interleave > 1u ? 2u : 1u) + n * ISM__FIELDS;
    size = blocks * 4u * sizeof(double) + (n + 65u) * sizeof(uint32_t);
    if (!ism__mul_size(floats, sizeof(float), &floats) || !ism__add_size(size, floats, &size)) {
        ism__log_value(&job->log, "points.count", (double)pixels, "less: its memory does not fit a size_t");
        return ISM_ERR_LIMIT;
    }
    size += n * sizeof(ism__orientation);
    memory = (char *)ism__alloc(&m->memory, size);
    if (!memory) return ism__no_memory(&job->log);
    ism__lay_out_shading(&w, memory, pixels, blocks);
    whole = ism__run(m, &job->part, 0.0f, w.interleave > 1u ? 0.9f : 1.0f, blocks, ism__shade_task, &w);
#ifndef ISM_WITHOUT_INTERLEAVED
    if (whole && w.interleave > 1u)
        whole = ism__run(m, &job->part, 0.9f, 1.0f, view->height, ism__smooth_task, &w);
#endif
    if (!whole) {
        ism__free(&m->memory, memory);
        return ISM_ERR_CANCELLED;
    }
    ism__reflect(view, w.interleave > 1u ? w.blurred : w.light, out);
    if (stats) {
        *stats = m->stats;
        ism__sum_lost(&w, blocks, stats);
        if (stats->bytes + size > stats->peak_bytes) stats->peak_bytes = stats->bytes + size;
    }
    ism__free(&m->memory, memory);
    return ISM_OK;
}

ISM_DEF ism_result ism_shade(const ism_maps *m, const ism_points *points, const ism_shading *shading,
                             float *out, ism_stats *stats)
{
    ism__job job;
    ism_shading none;
    ism_result result;
    if (!m) return ISM_ERR_ARGUMENT;
    ism__begin_job(&m->desc.system, "ism_shade", NULL, &job);
    if (!out) return ism__is_null(&job.log, "out");
    result = ism__open_view(&job.log, points, &job.view);
    memset(&none, 0, sizeof none);
    return result == ISM_OK ? ism__shade(m, &job, shading ? shading : &none, out, stats) : result;
}
