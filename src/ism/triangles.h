/* ---- triangles: which of them get points, by the view (paper 5.1, 5.2) and by each VPL ---- */

/* Successive triangles as one, for what a VPL sees of them: centroid, mean squared distance from it, area,
   and the mean of n n^T, which gives |n . direction| exactly where there is one normal. */
typedef struct ism__cluster { ism__v3 at; float radius2, area, n[6]; } ism__cluster;

typedef struct ism__spread_work {
    ism_maps        *m;
    const ism_mesh  *mesh;
    const ism__view  *view;
    const uint32_t  *valid;         /* pixels that are no background */
    uint32_t         valid_count;
    float           *area, *solid;  /* of each triangle */
    size_t           triangles;
    uint32_t         frame, period;
    int              fresh;
    ism__cdf         cdf;
    ism__cluster    *clusters;
    double          *seen;          /* share of each cluster by what the view sees */
    uint32_t         cluster_count, cluster_size;   /* size: triangles of each but the last */
} ism__spread_work;

enum { ISM__AHEAD = 16,             /* points whose memory is fetched before it is wanted */
       ISM__TRIANGLES = 4096,       /* a task's */
       ISM__CLUSTERS = 32768 };      /* at most */

/* Mean solid angle from the view samples of this triangle. Small ones by area cos / d^2: off by area / d^2 at
   most. */
static float ism__triangle_effect(const ism__spread_work *w, size_t t, const ism__v3 p[3], ism__v3 normal2)
{
    uint32_t count = w->m->desc.spread == ISM_SPREAD_VIEW_1 ? 1u : 8u, k;
    uint32_t key = ism__hash_combine(w->m->desc.seed, 0x7000u + (count == 1u ? 0u : (uint32_t)t));
    float sum = 0.0f, area2 = ism__v3_length(normal2);
    for (k = 0; k < count; k++) {
        uint32_t i = (uint32_t)((uint64_t)ism__hash_combine(key, k) * w->valid_count >> 32);
        ism__v3 v = ism__v3_load(
                    ism__at(w->view->points->positions, w->view->points->position_stride, w->valid[i])),
                a = ism__v3_sub(p[0], v);
        float d2 = ism__v3_dot(a, a);
        if (area2 < 0.01f * d2) {
            sum += 0.5f * fabsf(ism__v3_dot(normal2, a)) / (d2 * sqrtf(d2));
        } else {
            float corners[9];
            ism__v3_store(corners, a);
            ism__v3_store(corners + 3, ism__v3_sub(p[1], v));
            ism__v3_store(corners + 6, ism__v3_sub(p[2], v));
            sum += ism__solid_angle(corners, corners + 3, corners + 6);
        }
    }
    return sum / (float)count;
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
        else if (adaptive) solid = ism__triangle_effect(w, t, p, n);
        w->area[t] = area;
        w->solid[t] = ism__finite(solid) ? solid : 0.0f;
    }
}

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

/* Weight of a triangle: solid angle and, in the share that keeps edge-on triangles in, area. */
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

static void ism__cluster_task(void *context, size_t c)
{
    const ism__spread_work *w = (const ism__spread_work *)context;
    size_t t = c * w->cluster_size,
           end = t + w->cluster_size < w->triangles ? t + w->cluster_size : w->triangles;
    ism__v3 p[3], from;
    double at[3] = { 0.0, 0.0, 0.0 }, square = 0.0, sum = 0.0, nn[6] = { 0.0, 0.0, 0.0, 0.0, 0.0, 0.0 };
    ism__cluster *out = &w->clusters[c];
    int k;
    w->seen[c] = (w->cdf.sums[end] - w->cdf.sums[t]) / ism__cdf_total(&w->cdf);
    memset(out, 0, sizeof *out);
    for (from = ism__v3_make(0.0f, 0.0f, 0.0f); t < end; t++) {
        ism__v3 g, n;
        float area = w->area[t];
        if (!(area > 0.0f)) continue;
        ism__corners(w->mesh, t, p);
        n = ism__v3_scale(ism__v3_cross(ism__v3_sub(p[1], p[0]), ism__v3_sub(p[2], p[0])), 0.5f / area);
        if (!(sum > 0.0)) from = p[0];      /* sums of squares keep their digits far from the origin */
        for (k = 0; k < 3; k++) p[k] = ism__v3_sub(p[k], from);
        g = ism__v3_scale(ism__v3_add(ism__v3_add(p[0], p[1]), p[2]), 1.0f / 3.0f);
        sum += (double)area;
        at[0] += (double)(area * g.x);
        at[1] += (double)(area * g.y);
        at[2] += (double)(area * g.z);
        square += (double)(area * (9.0f * ism__v3_dot(g, g) + ism__v3_dot(p[0], p[0]) +
                                   ism__v3_dot(p[1], p[1]) + ism__v3_dot(p[2], p[2]))) /
                  12.0;
        nn[0] += (double)(area * n.x * n.x);
        nn[1] += (double)(area * n.y * n.y);
        nn[2] += (double)(area * n.z * n.z);
        nn[3] += (double)(area * n.y * n.z);
        nn[4] += (double)(area * n.z * n.x);
        nn[5] += (double)(area * n.x * n.y);
    }
    if (!(sum > 0.0)) return;
    for (k = 0; k < 6; k++) out->n[k] = (float)(nn[k] / sum);
    for (k = 0; k < 3; k++) at[k] /= sum;
    square = square / sum - at[0] * at[0] - at[1] * at[1] - at[2] * at[2];
    out->at = ism__v3_add(from, ism__v3_make((float)at[0], (float)at[1], (float)at[2]));
    out->radius2 = square > 0.0 ? (float)square : 0.0f;
    out->area = (float)sum;
}

/* Share of the VPL's map that a cluster fills, about: cosine-weighted solid angle, of a sky's map projected
   area. */
static float ism__cluster_effect(const ism__cluster *c, const ism_vpl *v)
{
    ism__v3 n = ism__v3_load(v->normal),
            l = v->directional ? n : ism__v3_sub(c->at, ism__v3_load(v->position));
    float away2 = ism__v3_dot(l, l), d2 = away2 + c->radius2 + 0.16f * c->area, along = ism__v3_dot(l, n),
          facing2;
    if (!(away2 > 0.0f) || !(c->area > 0.0f)) return c->area > 0.0f ? 1.0f : 0.0f;
    facing2 = c->n[0] * l.x * l.x + c->n[1] * l.y * l.y + c->n[2] * l.z * l.z +
              2.0f * (c->n[3] * l.y * l.z + c->n[4] * l.z * l.x + c->n[5] * l.x * l.y);
    facing2 = facing2 > 0.0f ? facing2 : 0.0f;
    if (v->directional) return c->area * sqrtf(facing2);
    facing2 += c->radius2 + 0.16f * c->area;     /* near ones are seen from all sides */
    along += sqrtf(c->radius2);
    return along > 0.0f ? c->area * sqrtf(facing2) * (along / (d2 * d2)) : 0.0f;
}

/* How many times the texels that it would have in an even map of the square a cluster has, about: the mean
   over a box of its size. Behind the horizon, where it may have a part in front, as on it. */
static float ism__cluster_zoom(const ism_maps *m, const ism__cluster *c, const ism_vpl *v,
                               const ism__orientation *f)
{
    const ism__window *w = (const ism__window *)m->windows.data + (v - m->vpls);
    ism__v3 from = ism__v3_load(v->directional ? m->center : v->position), at = ism__v3_sub(c->at, from);
    float uv[2], r = sqrtf(c->radius2), below = ism__v3_dot(f->z, at), d;
    float u0, u1, v0, v1;
    if (!w->u.on && !w->v.on) return 1.0f;
    d = v->directional ? m->radius : ism__v3_length(at);
    if (!v->directional && below < 0.05f * d) at = ism__v3_madd(at, f->z, 0.05f * d - below);
    if (!ism__square_of(m, v, f, ism__v3_add(from, at), uv)) return 1.0f;
    r = 0.5f * r / d;               /* a radian is half the square, about */
    r = r > 0.01f ? r : 0.01f;
    u0 = uv[0] > r ? uv[0] - r : 0.0f;
    v0 = uv[1] > r ? uv[1] - r : 0.0f;
    u1 = uv[0] + r < 1.0f ? uv[0] + r : 1.0f;
    v1 = uv[1] + r < 1.0f ? uv[1] + r : 1.0f;
    return (ism__to_tile(&w->u, u1) - ism__to_tile(&w->u, u0)) / (u1 - u0) *
           ((ism__to_tile(&w->v, v1) - ism__to_tile(&w->v, v0)) / (v1 - v0));
}

/* The clusters' shares of a VPL's points, summed: by the geometric mean of what the view and the VPL see of
   them, and a little by each, so that none is forgotten. */
static void ism__share_clusters(const ism__spread_work *w, const ism_vpl *v, float *effect, double *sums)
{
    double seen = 0.0, sum = 0.0;
    ism__orientation f;
    uint32_t c;
    memset(&f, 0, sizeof f);
    if (v) f = ism__vpl_frame(w->m, v);
    for (c = 0; c < w->cluster_count; c++) {
        effect[c] = v ? ism__cluster_effect(&w->clusters[c], v) : 0.0f;
        if (effect[c] > 0.0f) effect[c] *= ism__cluster_zoom(w->m, &w->clusters[c], v, &f);
        effect[c] = ism__finite(effect[c]) ? effect[c] : 0.0f;
        seen += (double)effect[c];
    }
    for (c = 0; c < w->cluster_count; c++) {
        double p = w->seen[c];
        double q = seen > 0.0 ? (double)effect[c] / seen : p;
        sums[c] = sum;
        if (p > 0.0) sum += sqrt(p * q) + ISM__EITHER * (p + q);
    }
    sums[c] = sum;
}
