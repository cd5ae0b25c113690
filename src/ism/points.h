/* ---- points: surfels on all triangles (paper 5) ---- */

/* Writes barycentric coordinates of a place (u, v) in the square; an even density stays even. After Heitz, "A
   low-distortion map between triangle and square", 2019: nothing is folded, so that points of low discrepancy
   stay such. */
static void ism__triangle_map(float u, float v, float *b1, float *b2)
{
    if (v > u) {
        u *= 0.5f;
        v -= u;
    } else {
        v *= 0.5f;
        u -= v;
    }
    *b1 = u;
    *b2 = v;
}

/* Returns the cell i among first <= i < end with sums[i] <= x < sums[i + 1], never one without width. The
   search begins at `from`, if that is not behind x, by steps that double, since successive points lie in
   successive cells. */
static size_t ism__find(const double *sums, size_t first, size_t end, size_t from, double x)
{
    size_t lo = first, hi = end, step = 1;
    if (from > first && sums[from] <= x) {
        for (lo = from; end - lo > step && sums[lo + step] <= x; step *= 2u) lo += step;
        if (end - lo > step) hi = lo + step;
    }
    while (hi - lo > 1u) {
        size_t middle = lo + (hi - lo) / 2u;
        if (sums[middle] <= x) lo = middle;
        else hi = middle;
    }
    while (lo > first && !(sums[lo + 1u] > sums[lo])) lo--;
    while (lo + 1u < end && !(sums[lo + 1u] > sums[lo])) lo++;
    return lo;
}

/* Draws a triangle of cluster c, by the place of x within the cluster's share. Returns the probability with
   which this triangle is drawn among all. */
static double ism__choose_triangle(const ism__spread_work *w, const double *shares, size_t c, double x,
                                 uint32_t *triangle)
{
    const double *sums = w->cdf.sums;
    size_t first = c * w->cluster_size, end = first + w->cluster_size, t;
    double share = shares[c + 1u] - shares[c], width;
    if (end > w->triangles) end = w->triangles;
    width = sums[end] - sums[first];
    t = ism__find(sums, first, end, first, sums[first] + (x - shares[c]) / share * width);
    *triangle = (uint32_t)t;
    return share / shares[w->cluster_count] * ((sums[t + 1u] - sums[t]) / width);
}

/* Returns whether a point of a mesh lies in a hole of its mask. */
static int ism__is_hole(const ism_mesh *mesh, const ism__surfel *p)
{
    float weights[3];
    if (!mesh->mask_fn) return 0;
    weights[1] = (float)p->b1 * (1.0f / 65535.0f);
    weights[2] = (float)p->b2 * (1.0f / 65535.0f);
    weights[0] = 1.0f - weights[1] - weights[2];
    return !mesh->mask_fn(mesh->user, p->triangle, weights);
}

/* Makes point `at` of n anew, on a triangle of cluster c, by where x lies in its share. Points in holes of a
   mask stand for no area, the others for as much as without a mask: together for what is there. */
static void ism__make_point(const ism__spread_work *w, const double *shares, size_t c, double x, uint32_t key,
                            uint32_t at, uint32_t n, ism__surfel *to)
{
    uint32_t r = key + at * 3242174889u, s = ism__hash32(key) + at * 2447445413u;
    double probability = ism__choose_triangle(w, shares, c, x, &to->triangle);
    float b1, b2;
    ism__triangle_map(ism__to_unit(r), ism__to_unit(s), &b1, &b2);
    to->b1 = (uint16_t)(b1 * 65535.0f);
    to->b2 = (uint16_t)(b2 * 65535.0f);
    to->weight = probability > 0.0 ? (float)(1.0 / ((double)n * probability)) : 0.0f;
    if (ism__is_hole(w->mesh, to)) to->weight = 0.0f;
}

/* Makes the points of a VPL's tile. Each VPL has stratified random numbers (j + r) / n of its own, the same
   in every frame, so that a static scene stays as it is; one in lazy_frames of the points is made anew. So
   are points whose triangles are gone, from all triangles, since they were neighbours in the strata. Clusters
   are found for several points at once; sums of triangles are fetched meanwhile: no cache holds them all. */
static void ism__points_of(const ism__spread_work *w, size_t v, const double *shares)
{
    ism_maps *m = w->m;
    uint32_t *counts = (uint32_t *)m->counts.data + 2u * v;
    ism__surfel *points = (ism__surfel *)m->surfels.data + v * m->desc.surfel_count;
    const uint32_t n = counts[0], phase = w->frame % w->period;
    const int fresh = w->fresh || n != counts[1];
    const uint32_t step = fresh || w->fewer ? 1u : w->period;
    const uint32_t seed = m->desc.unstable ? ism__hash_combine(m->desc.seed, w->frame) : m->desc.seed;
    const uint32_t key = ism__hash_combine(seed, 0x9000u + (uint32_t)v);
    const uint32_t again = ism__hash_combine(key, w->frame);
    uint32_t numbers[ISM__AHEAD], clusters[ISM__AHEAD];
    uint32_t j, k, used;
    double x[ISM__AHEAD];
    size_t c = 0, i;
    counts[1] = 0;
    for (j = step > 1u ? phase : 0; j < n;) {
        for (used = 0; used < ISM__AHEAD && j < n; j += step) {
            const int due = fresh || j % w->period == phase;
            const double unit = (double)ism__to_unit(ism__hash_combine(due ? key : again, j));
            if (!due && points[j].triangle < w->triangles) continue;
            x[used] = (due ? ((double)j + unit) / (double)n : unit) * shares[w->cluster_count];
            c = ism__find(shares, 0, w->cluster_count, c, x[used]);
            for (i = c * w->cluster_size; i <= w->triangles && i <= (c + 1u) * w->cluster_size; i += 8u)
                ISM__PREFETCH(w->cdf.sums + i);
            clusters[used] = (uint32_t)c;
            numbers[used++] = j;
        }
        for (k = 0; k < used; k++)
            ism__make_point(w, shares, clusters[k], x[k], key, numbers[k], n, &points[numbers[k]]);
        counts[1] += used;
    }
}

/* Returns how many doubles a lane needs: prefix sums of shares, and as many floats for clusters' effects. */
static size_t ism__lane_shares(const ism__spread_work *w)
{
    return (size_t)w->cluster_count + w->cluster_count / 2u + 2u;
}

/* Makes the points of every ISM__LANES-th VPL. Each lane has memory of its own for shares. */
static void ism__points_task(void *context, size_t lane)
{
    const ism__spread_work *w = (const ism__spread_work *)context;
    ism_maps *m = w->m;
    double *shares = (double *)m->shares.data + lane * ism__lane_shares(w);
    float *effect = (float *)(void *)(shares + w->cluster_count + 1u);
    int pair = m->desc.spread == ISM_SPREAD_PAIR && w->valid_count > 0;
    size_t v;
    for (v = lane; v < m->desc.vpl_count; v += ISM__LANES) {
        if (v == lane || pair)
            ism__share_clusters(w, pair && v < m->vpl_count ? &m->vpls[v] : NULL, effect, shares);
        ism__points_of(w, v, shares);
    }
}

/* Writes for each VPL how many points it has, and how many it had in the frame before, in whose place
   ism__points_of puts how many it made anew. */
static void ism__count_points(ism_maps *m, int fresh)
{
    uint32_t *counts = (uint32_t *)m->counts.data, i;
    double sum = 0.0, mean;
    for (i = 0; i < m->vpl_count; i++) sum += (double)ism__luminance(m->vpls[i].flux);
    mean = m->vpl_count ? sum / (double)m->vpl_count : 0.0;
    for (i = 0; i < m->desc.vpl_count; i++) {
        double f = i < m->vpl_count ? (double)ism__luminance(m->vpls[i].flux) : mean;
        uint32_t n = m->desc.surfel_count;
        if (m->desc.vary_surfels && f < 0.5 * mean) n = f < 0.25 * mean ? n / 4u : n / 2u;
        counts[2u * i + 1u] = fresh ? 0 : counts[2u * i];
        counts[2u * i] = n;
    }
}

/* Finds the sphere that maps of directions show. */
static void ism__bounding_sphere(ism_maps *m, const ism_mesh *mesh)
{
    ism__v3 lo = ism__v3_make(1e30f, 1e30f, 1e30f), hi = ism__v3_make(-1e30f, -1e30f, -1e30f), c;
    size_t i;
    for (i = 0; mesh && i < mesh->vertex_count; i++) {
        ism__v3 p = ism__v3_load(ism__at(mesh->positions, mesh->vertex_stride, i));
        if (!ism__v3_finite(p) || fabsf(p.x) > 1e18f || fabsf(p.y) > 1e18f || fabsf(p.z) > 1e18f) continue;
        lo = ism__v3_min(lo, p);
        hi = ism__v3_max(hi, p);
    }
    if (!(lo.x <= hi.x)) lo = hi = ism__v3_make(0, 0, 0);
    c = ism__v3_scale(ism__v3_add(lo, hi), 0.5f);
    ism__v3_store(m->center, c);
    m->radius = 0.5f * ism__v3_length(ism__v3_sub(hi, lo)) * 1.001f + 1e-20f;
}

/* Makes room for the points and for the distributions from which they are drawn. Returns 0 if there is no
   memory. */
static int ism__hold_points(ism_maps *m, ism__spread_work *w)
{
    const size_t vpls = m->desc.vpl_count, bundles = w->cluster_count / ISM__BUNDLE + 1u;
    if (!ism__grow(m, &m->weights, w->triangles, 2u * sizeof(float)) ||
        !ism__grow(m, &m->clusters, bundles, sizeof(ism__clusters) + ISM__BUNDLE * sizeof(double)) ||
        !ism__grow(m, &m->shares, ISM__LANES * ism__lane_shares(w), sizeof(double)) ||
        !ism__grow(m, &m->sums, w->triangles + 1u, sizeof(double)) ||
        !ism__grow(m, &m->surfels, vpls * m->desc.surfel_count, sizeof(ism__surfel)) ||
        !ism__grow(m, &m->counts, vpls * 2u, sizeof(uint32_t)))
        return 0;
    w->valid = (const uint32_t *)m->pixels.data;
    w->area = (float *)m->weights.data;
    w->solid = w->area + w->triangles;
    w->seen = (double *)m->clusters.data;
    w->clusters = (ism__clusters *)(void *)(w->seen + bundles * ISM__BUNDLE);
    memset(w->clusters + bundles - 1u, 0, sizeof *w->clusters);     /* kernels read the whole last bundle */
    return 1;
}

/* Makes the surfels of a frame: triangles are weighed, then clusters of them, then points are drawn. */
static ism_result ism__renew_points(ism_maps *m, const ism__job *job)
{
    const ism_frame *f = job->frame;
    ism__spread_work w;
    double area = 0.0, solid = 0.0;
    size_t t;
    ism_result result;
    memset(&w, 0, sizeof w);
    w.m = m;
    w.mesh = f->mesh;
    w.view = &job->view;
    w.triangles = ism__mesh_triangles(f->mesh);
    w.frame = f->index;
    w.period = m->desc.unstable ? 1u : m->desc.lazy_frames;
    w.fresh = !m->triangles;
    w.fewer = w.triangles < m->triangles;
    ism__choose_spread(&w);
    if (w.triangles >= 1u << 31) {
        ism__log_value(&job->log, "the mesh's count of triangles", (double)w.triangles, "below 2^31");
        return ISM_ERR_LIMIT;
    }
    w.cluster_size = (uint32_t)(w.triangles / ISM__CLUSTERS) + 1u;
    w.cluster_count = (uint32_t)((w.triangles + w.cluster_size - 1u) / w.cluster_size);
    result = ism__valid_pixels(m, &job->view, &w.valid_count);
    if (result == ISM_ERR_ALLOC) return ism__no_memory(&job->log);
    if (result != ISM_OK) return result;
    if (!ism__hold_points(m, &w)) return ism__no_memory(&job->log);
    if (!ism__run(m, &job->part, 0.1f, 0.4f, (w.triangles + ISM__TRIANGLES - 1u) / ISM__TRIANGLES,
                  ism__spread_task, &w))
        return ISM_ERR_CANCELLED;
    m->stats.skipped_triangles = 0;
    for (t = 0; t < w.triangles; t++) {
        if (w.area[t] < 0.0f) return ism__check_indices(&job->log, f->mesh);
        m->stats.skipped_triangles += w.area[t] > 0.0f ? 0u : 1u;
        area += (double)w.area[t];
        solid += (double)w.solid[t];
    }
    m->stats.surface_area = area;
    m->stats.surfels = m->stats.renewed = 0;
    if (!(area > 0.0)) {
        m->triangles = 0;
        return ISM_OK;
    }
    ism__make_cdf(&w, area, solid);
    if (!ism__run(m, &job->part, 0.4f, 0.5f, w.cluster_count, ism__cluster_task, &w))
        return ISM_ERR_CANCELLED;
    ism__count_points(m, w.fresh);
    m->triangles = 0;               /* set once all points are made: a cancelled renewal begins anew */
    if (!ism__run(m, &job->part, 0.5f, 1.0f, ISM__LANES, ism__points_task, &w)) return ISM_ERR_CANCELLED;
    m->triangles = w.triangles;
    for (t = 0; t < 2u * (size_t)m->desc.vpl_count; t++)
        *(t & 1u ? &m->stats.renewed : &m->stats.surfels) += ((const uint32_t *)m->counts.data)[t];
    return ISM_OK;
}

/* Makes surfels and windows, without maps. */
static ism_result ism__scatter(ism_maps *m, const ism__job *job)
{
    const ism_frame *f = job->frame;
    ism_result result = f->mesh ? ism__check_mesh(&job->log, f->mesh) : ISM_OK;
    if (result == ISM_OK && f->mesh) result = ism__check_opacities(&job->log, f->mesh);
    if (result != ISM_OK) return result;
    m->built = 0;
    if (!ism__grow(m, &m->windows, m->desc.vpl_count, sizeof(ism__window) + sizeof(uint32_t)))
        return ism__no_memory(&job->log);
    ism__bounding_sphere(m, f->mesh);
#ifndef ISM_WITHOUT_WINDOWS
    if (!ism__make_windows(m, &job->view, &job->part)) return ISM_ERR_CANCELLED;
#else
    memset(m->windows.data, 0, m->desc.vpl_count * sizeof(ism__window));
#endif
    return ism__renew_points(m, job);
}

/* Logs what the call needs and the maps do not have yet, and returns ISM_ERR_ORDER. */
static ism_result ism__too_early(const ism__logger *log, const char *name, const char *needs)
{
    ism__log_text(log, name, needs);
    return ISM_ERR_ORDER;
}

ISM_DEF ism_result ism_scatter(ism_maps *m, const ism_frame *f)
{
    ism__job job;
    ism_result result = ism__open_frame(m, f, "ism_scatter", &job);
    if (result != ISM_OK) return result;
    return m->chosen ? ism__scatter(m, &job)
                     : ism__too_early(&job.log, "maps", "have no VPLs: call ism_choose before");
}

static ism_surfel ism__unpack_surfel(const ism__surfel *p)
{
    ism_surfel out;
    out.triangle = p->triangle;
    out.barycentric[0] = (float)p->b1 * (1.0f / 65535.0f);
    out.barycentric[1] = (float)p->b2 * (1.0f / 65535.0f);
    out.area = p->weight;
    return out;
}

static ism_result ism__no_surfels(const ism__logger *log)
{
    return ism__too_early(log, "maps", "have no surfels: call ism_build before, with a mesh");
}

ISM_DEF ism_result ism_surfels(const ism_maps *m, uint32_t vpl, ism_surfel *out, size_t capacity,
                               size_t *count)
{
    const ism__surfel *points;
    uint32_t n, j;
    ism__job job;
    if (!m) return ISM_ERR_ARGUMENT;
    ism__begin_job(&m->desc.system, "ism_surfels", NULL, &job);
    if (ism__check_list(&job.log, out, capacity, count) != ISM_OK) return ISM_ERR_ARGUMENT;
    if (vpl >= m->desc.vpl_count) {
        ism__log_value(&job.log, "vpl", (double)vpl, "below desc.vpl_count");
        return ISM_ERR_ARGUMENT;
    }
    if (!m->triangles) return ism__no_surfels(&job.log);
    points = (const ism__surfel *)m->surfels.data + (size_t)vpl * m->desc.surfel_count;
    n = ((const uint32_t *)m->counts.data)[2u * vpl];
    for (j = 0; j < n && j < capacity; j++) out[j] = ism__unpack_surfel(&points[j]);
    *count = n;
    return ISM_OK;
}

ISM_DEF ism_result ism_phase_surfels(const ism_maps *m, uint32_t phase, ism_surfel *out, size_t capacity,
                                     size_t *count)
{
    uint32_t each, v, j;
    size_t k = 0;
    ism__job job;
    if (!m) return ISM_ERR_ARGUMENT;
    ism__begin_job(&m->desc.system, "ism_phase_surfels", NULL, &job);
    if (ism__check_list(&job.log, out, capacity, count) != ISM_OK) return ISM_ERR_ARGUMENT;
    if (phase >= m->desc.lazy_frames) {
        ism__log_value(&job.log, "phase", (double)phase, "below desc.lazy_frames");
        return ISM_ERR_ARGUMENT;
    }
    if (!m->triangles) return ism__no_surfels(&job.log);
    each = (m->desc.surfel_count + m->desc.lazy_frames - 1u) / m->desc.lazy_frames;
    *count = (size_t)m->desc.vpl_count * each;
    for (v = 0; v < m->desc.vpl_count; v++) {
        const ism__surfel *points = (const ism__surfel *)m->surfels.data + (size_t)v * m->desc.surfel_count;
        uint32_t n = ((const uint32_t *)m->counts.data)[2u * v];
        for (j = 0; j < each && k < capacity; j++, k++) {
            uint32_t i = phase + j * m->desc.lazy_frames;
            memset(&out[k], 0, sizeof *out);
            if (i < n) out[k] = ism__unpack_surfel(&points[i]);
        }
    }
    return ISM_OK;
}
