/* ---- kernels: a-trous, the mean of neighbours that are alike ---- */

typedef struct gifilt__means { gifilt__lanes3 rgb, most; gifilt__lanes total; } gifilt__means;

/* Returns means, none of them brighter than the brightest neighbour if only few neighbours are like the
   pixel. In a mean over few the noise of the pixel's own samples stays: of 25 lights that stand for 400, one
   that is near counts 16 times. The mean's weights add up to 16 at most, of which 4 are the pixel's own. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__despeckled(gifilt__lanes sum, gifilt__lanes total,
                                                                 gifilt__lanes most, gifilt__lane_mask few)
{
    const gifilt__lanes x = gifilt__lanes_div(sum, total);
    const gifilt__lane_mask lit = gifilt__lanes_greater(most, gifilt__lanes_all(0.0f));
    few = gifilt__mask_and(gifilt__mask_and(few, lit), gifilt__lanes_greater(x, most));
    return gifilt__lanes_select(few, most, x);
}

/* Adds one neighbour of every lane to the means: its shape lies from q on, its colour from c on, in planes s
   floats apart. */
static inline GIFILT__IN_KERNEL gifilt__means gifilt__add_tap(gifilt__means means, const gifilt__shapes *own,
                                                              const float *q, const float *c, size_t s,
                                                              float share, const float limits[3])
{
    const gifilt__shapes shapes = gifilt__shapes_load(q, s);
    const gifilt__lanes3 rgb = gifilt__lanes3_load(c, c + s, c + 2 * s);
    const gifilt__lanes alike = gifilt__alike(own, &shapes, limits);
    const gifilt__lanes weight = gifilt__lanes_mul(alike, gifilt__lanes_all(share));
    means.rgb.x = gifilt__lanes_add(means.rgb.x, gifilt__lanes_mul(weight, rgb.x));
    means.rgb.y = gifilt__lanes_add(means.rgb.y, gifilt__lanes_mul(weight, rgb.y));
    means.rgb.z = gifilt__lanes_add(means.rgb.z, gifilt__lanes_mul(weight, rgb.z));
    means.total = gifilt__lanes_add(means.total, weight);
    means.most.x = gifilt__lanes_max(rgb.x, means.most.x);
    means.most.y = gifilt__lanes_max(rgb.y, means.most.y);
    means.most.z = gifilt__lanes_max(rgb.z, means.most.z);
    return means;
}

/* Takes one pass of the a-trous filter on as many pixels as there are lanes. */
static inline GIFILT__IN_KERNEL gifilt__lanes3 gifilt__smooth_some(const gifilt__filter_run *r,
                                                                   const float *p,
                                                                   const float *rgb, const gifilt__tap *taps,
                                                                   size_t count)
{
    const float limits[3] = { r->limits[0], r->limits[1], r->limits[2] };
    const size_t s = r->filter->spacing;
    const gifilt__shapes own = gifilt__shapes_load(p, s);
    const gifilt__lanes four = gifilt__lanes_all(4.0f);
    gifilt__means means;
    gifilt__lanes3 out;
    gifilt__lane_mask few;
    size_t k;
    means.rgb.x = gifilt__lanes_mul(four, gifilt__lanes_load(rgb));
    means.rgb.y = gifilt__lanes_mul(four, gifilt__lanes_load(rgb + s));
    means.rgb.z = gifilt__lanes_mul(four, gifilt__lanes_load(rgb + 2 * s));
    means.total = four;
    means.most = gifilt__lanes3_all(0.0f, 0.0f, 0.0f);
    for (k = 0; k < count; k++)
        means = gifilt__add_tap(means, &own, p + taps[k].shape, rgb + taps[k].rgb, s, taps[k].weight, limits);
    few = gifilt__lanes_greater(gifilt__lanes_all(8.0f), means.total);
    out.x = gifilt__despeckled(means.rgb.x, means.total, means.most.x, few);
    out.y = gifilt__despeckled(means.rgb.y, means.total, means.most.y, few);
    out.z = gifilt__despeckled(means.rgb.z, means.total, means.most.z, few);
    return out;
}

/* Takes one pass on a row: means over 3 x 3 pixels that are r->step apart. */
GIFILT__KERNEL static void gifilt__smooth(const gifilt__filter_run *r, size_t y)
{
    const gifilt_filter *f = r->filter;
    const float *p = f->next + y * GIFILT__PLANES * f->spacing, *rgb = r->in + y * r->in_row;
    float *to = r->out + y * r->out_row, some[3 * GIFILT__LANE_COUNT];
    const size_t lanes = GIFILT__LANE_COUNT;
    size_t x, c, width = f->width;
    gifilt__tap taps[8];
    size_t count = gifilt__taps(r, y, taps), below = y + r->step + 1 < f->height ? r->step + 1 : 0;
    size_t ahead = below * GIFILT__PLANES * f->spacing, rgb_ahead = below * r->in_row;
    for (x = 0; x < width; x += lanes) {
        size_t end = width - x < lanes ? width - x : lanes;
        gifilt__lanes3 out;
        gifilt__fetch_ahead(p + x + ahead, f->spacing, GIFILT__RGB);
        gifilt__fetch_ahead(rgb + x + rgb_ahead, f->spacing, 3);
        out = gifilt__smooth_some(r, p + x, rgb + x, taps, count);
        if (r->packed) {
            gifilt__lanes3_store_packed(some, out);
            memcpy(to + 3 * x, some, 3 * end * sizeof *to);
            continue;
        }
        gifilt__lanes_store(some, out.x);
        gifilt__lanes_store(some + lanes, out.y);
        gifilt__lanes_store(some + 2 * lanes, out.z);
        for (c = 0; c < 3; c++)
            if (end == lanes) memcpy(to + c * f->spacing + x, some + c * lanes, lanes * sizeof *to);
            else memcpy(to + c * f->spacing + x, some + c * lanes, end * sizeof *to);   /* margins stay 0 */
    }
}
