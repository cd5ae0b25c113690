/* ---- clusters: triangles are put together, for what a VPL sees of them ---- */

/* Measures cluster c, which is triangles t to end - 1. A cluster without area is all 0, since kernels compute
   on its lane too. */
static void ism__measure_cluster(const ism__spread_work *w, size_t c, size_t t, size_t end)
{
    ism__v3 p[3], from;
    double at[3] = { 0.0, 0.0, 0.0 }, square = 0.0, sum = 0.0, nn[6] = { 0.0, 0.0, 0.0, 0.0, 0.0, 0.0 };
    ism__clusters *out = &w->clusters[c / ISM__BUNDLE];
    size_t lane = c % ISM__BUNDLE;
    int k;
    out->area[lane] = out->radius2[lane] = 0.0f;
    for (k = 0; k < 3; k++) out->at[k][lane] = 0.0f;
    for (k = 0; k < 6; k++) out->n[k][lane] = 0.0f;
    for (from = ism__v3_make(0.0f, 0.0f, 0.0f); t < end; t++) {
        ism__v3 g, n;
        float area = w->area[t];
        if (!(area > 0.0f)) continue;
        ism__corners(w->mesh, t, p);
        n = ism__v3_scale(ism__v3_cross(ism__v3_sub(p[1], p[0]), ism__v3_sub(p[2], p[0])), 0.5f / area);
        if (!(sum > 0.0)) from = p[0];      /* places are relative to this one, so that sums of squares
                                               keep their digits far from the origin */
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
    for (k = 0; k < 6; k++) out->n[k][lane] = (float)(nn[k] / sum);
    for (k = 0; k < 3; k++) at[k] /= sum;
    square = square / sum - at[0] * at[0] - at[1] * at[1] - at[2] * at[2];
    out->at[0][lane] = from.x + (float)at[0];
    out->at[1][lane] = from.y + (float)at[1];
    out->at[2][lane] = from.z + (float)at[2];
    out->radius2[lane] = square > 0.0 ? (float)square : 0.0f;
    out->area[lane] = (float)sum;
}
