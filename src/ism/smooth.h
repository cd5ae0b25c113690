/* ---- smooth: the blur of interleaved pictures (paper 6.2) ---- */

/* Writes a pixel's mean over a window in which each class of VPLs occurs once (those at the rim half on
   either side), of neighbours on the same smooth surface. Neighbours are not chosen too strictly: where few
   are left, so are few VPLs, and spots stay. */
static void ism__smooth_pixel(const ism__shade_work *w, int x, int y, float out[3])
{
    const ism__view *view = w->view;
    int r = (int)w->interleave / 2, i, j;
    int k, width = (int)view->width, height = (int)view->height;
    float weights = 0.0f, sum[3] = { 0.0f, 0.0f, 0.0f };
    ism__v3 p, n, q, nq;
    if (!ism__receiver(view, (size_t)y * view->width + (size_t)x, &p, &n)) {
        out[0] = out[1] = out[2] = 0.0f;
        return;
    }
    for (j = -r; j <= r; j++)
        for (i = -r; i <= r; i++) {
            size_t at = (size_t)(y + j) * view->width + (size_t)(x + i);
            float weight = (i == -r || i == r ? 0.5f : 1.0f) * (j == -r || j == r ? 0.5f : 1.0f), facing, off;
            ism__v3 d;
            if (x + i < 0 || y + j < 0 || x + i >= width || y + j >= height ||
                !ism__receiver(view, at, &q, &nq))
                continue;
            d = ism__v3_sub(q, p);
            facing = ism__v3_dot(n, nq);
            off = fabsf(ism__v3_dot(n, d)) + fabsf(ism__v3_dot(nq, d));
            weight *= facing > 0.0f ? facing * facing : 0.0f;
            if (off > 0.0f) {       /* d leaves the tangent planes by this share of its length */
                off = 1.0f - off / ism__v3_length(d);
                weight *= off > 0.0f ? off : 0.0f;
            }
            for (k = 0; k < 3; k++) sum[k] += weight * w->light[3u * at + (size_t)k];
            weights += weight;
        }
    for (k = 0; k < 3; k++) out[k] = weights > 0.0f ? sum[k] / weights : 0.0f;
}

static void ism__smooth_task(void *context, size_t row)
{
    const ism__shade_work *w = (const ism__shade_work *)context;
    size_t x;
    for (x = 0; x < w->view->width; x++)
        ism__smooth_pixel(w, (int)x, (int)row, w->blurred + 3u * (row * w->view->width + x));
}
