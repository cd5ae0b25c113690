/* ---- triangles: which of them get points, by the view (paper 5.1, 5.2) and by each VPL ---- */

/* Returns a triangle's mean solid angle as seen from its receivers. */
static float ism__seen_by_view(const ism__spread_work *w, size_t t, const ism__v3 p[3], ism__v3 normal2)
{
    const ism_points *points = w->view->points;
    uint32_t count = w->m->desc.spread == ISM_SPREAD_VIEW_1 ? 1u : (uint32_t)ISM__VIEWS, k;
    uint32_t key = ism__hash_combine(w->m->desc.seed, 0x7000u + (count == 1u ? 0u : (uint32_t)t));
    float views[3][ISM__VIEWS] = { { 0.0f } };
    for (k = 0; k < count; k++) {
        uint32_t i = (uint32_t)((uint64_t)ism__hash_combine(key, k) * w->valid_count >> 32);
        const float *v = ism__at(points->positions, points->position_stride, w->valid[i]);
        views[0][k] = v[0];
        views[1][k] = v[1];
        views[2][k] = v[2];
    }
    return w->mean_solid_angle(p, normal2, (const float (*)[ISM__VIEWS])views, count);
}

static void ism__spread_task(void *context, size_t index)
{
    ism__spread_work *w = (ism__spread_work *)context;
    size_t t = index * ISM__TRIANGLES,
           end = t + ISM__TRIANGLES < w->triangles ? t + ISM__TRIANGLES : w->triangles;
    int adaptive = w->m->desc.spread != ISM_SPREAD_AREA && w->valid_count > 0;
    for (; t < end; t++) {
        ism__v3 p[3], n;
        float area, solid = 0.0f;
        if (ism__index(w->mesh, 3u * t) >= w->mesh->vertex_count ||
            ism__index(w->mesh, 3u * t + 1u) >= w->mesh->vertex_count ||
            ism__index(w->mesh, 3u * t + 2u) >= w->mesh->vertex_count) {
            w->area[t] = -1.0f;     /* an error, found by the thread that called us */
            continue;
        }
        ism__corners(w->mesh, t, p);
        n = ism__v3_cross(ism__v3_sub(p[1], p[0]), ism__v3_sub(p[2], p[0]));
        area = 0.5f * ism__v3_length(n);
        if (!(area > 0.0f) || !ism__finite(area)) area = 0.0f;
        else if (adaptive) solid = ism__seen_by_view(w, t, p, n);
        w->area[t] = area;
        w->solid[t] = ism__finite(solid) ? solid : 0.0f;
    }
}

/* Lists the pixels that are no background. */
static ism_result ism__valid_pixels(ism_maps *m, const ism__view *view, uint32_t *count)
{
    size_t pixels = (size_t)view->width * view->height, i;
    uint32_t *valid;
    ism__v3 p, n;
    if (!ism__grow(m, &m->pixels, pixels, sizeof *valid)) return ISM_ERR_ALLOC;
    valid = (uint32_t *)m->pixels.data;
    for (*count = 0, i = 0; i < pixels; i++)
        if (ism__receiver(view, i, &p, &n)) valid[(*count)++] = (uint32_t)i;
    return ISM_OK;
}

/* Makes the prefix sums from which triangles are drawn: of solid angles, and of a share of areas, so that
   triangles that are seen from their edge are drawn too. */
static void ism__make_cdf(ism__spread_work *w, double area_sum, double solid_sum)
{
    ism_maps *m = w->m;
    double a = solid_sum > 0.0 ? (double)m->desc.area_share / area_sum : 1.0 / area_sum;
    double s = solid_sum > 0.0 ? (1.0 - (double)m->desc.area_share) / solid_sum : 0.0,
           *sums = (double *)m->sums.data;
    double sum = 0.0;
    size_t t;
    for (t = 0; t < w->triangles; t++) {
        sums[t] = sum;
        if (w->area[t] > 0.0f) sum += a * (double)w->area[t] + s * (double)w->solid[t];
    }
    sums[w->triangles] = sum;
    w->cdf.sums = sums;
    w->cdf.count = (uint32_t)w->triangles;
}

/* Finds which share of the points a cluster gets by what the view sees, and measures the cluster for VPLs. */
static void ism__cluster_task(void *context, size_t c)
{
    const ism__spread_work *w = (const ism__spread_work *)context;
    size_t t = c * w->cluster_size;
    size_t end = t + w->cluster_size < w->triangles ? t + w->cluster_size : w->triangles;
    w->seen[c] = (w->cdf.sums[end] - w->cdf.sums[t]) / ism__cdf_total(&w->cdf);
#ifndef ISM_WITHOUT_PAIR
    ism__measure_cluster(w, c, t, end);
#endif
}

/* Writes prefix sums of the clusters' shares of a VPL's points. A share is the geometric mean of what the
   view and the VPL see of the cluster, and a little of either alone, so that no cluster is forgotten. v: NULL
   = only the view counts. */
static void ism__share_clusters(const ism__spread_work *w, const ism_vpl *v, float *effect, double *sums)
{
    double seen = 0.0, sum = 0.0;
    uint32_t c;
#ifndef ISM_WITHOUT_PAIR
    if (v) w->weigh_clusters(w, v, effect);
#endif
    for (c = 0; v && c < w->cluster_count; c++) seen += (double)effect[c];
    for (c = 0; c < w->cluster_count; c++) {
        double p = w->seen[c];
        double q = seen > 0.0 ? (double)effect[c] / seen : p;
        sums[c] = sum;
        if (p > 0.0) sum += sqrt(p * q) + ISM__EITHER * (p + q);
    }
    sums[c] = sum;
}
