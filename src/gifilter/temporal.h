/* ---- kernels: what the last frames knew of each pixel ---- */

/* Marks the lanes whose absolute value is at most `most`; what is not a number is never marked. */
static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__at_most(gifilt__lanes a, float most)
{
    return gifilt__lanes_at_least(gifilt__lanes_all(most), gifilt__lanes_abs(a));
}

static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__at_most3(gifilt__lanes3 a, float most)
{
    const gifilt__lane_mask m = gifilt__mask_and(gifilt__at_most(a.x, most), gifilt__at_most(a.y, most));
    return gifilt__mask_and(m, gifilt__at_most(a.z, most));
}

/* Marks the vectors of which a coordinate is above or below 0; one that has no number in it is not marked. */
static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__not_zero(gifilt__lanes3 a)
{
    const gifilt__lanes zero = gifilt__lanes_all(0.0f);
    const gifilt__lane_mask m = gifilt__mask_or(gifilt__lanes_greater(gifilt__lanes_abs(a.x), zero),
                                                gifilt__lanes_greater(gifilt__lanes_abs(a.y), zero));
    return gifilt__mask_or(m, gifilt__lanes_greater(gifilt__lanes_abs(a.z), zero));
}

static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__are_there(const gifilt__chunk *k, size_t l)
{
    return gifilt__lanes_greater(gifilt__lanes_load(k->there + l), gifilt__lanes_all(0.0f));
}

static inline GIFILT__IN_KERNEL void gifilt__set_there(gifilt__chunk *k, size_t l, gifilt__lane_mask there)
{
    gifilt__lanes_store(k->there + l, gifilt__lanes_keep(there, gifilt__lanes_all(1.0f)));
}

/* Finds which pixels of a chunk show something, and copies what this frame sees of them. */
static inline GIFILT__IN_KERNEL void gifilt__chunk_set(gifilt__chunk *k)
{
    const gifilt__lanes least = gifilt__lanes_all(1e-12f);
    size_t l, c;
    for (l = 0; l < GIFILT__SPAN; l += GIFILT__LANE_COUNT) {
        const float (*g)[GIFILT__SPAN + 1] = (const float (*)[GIFILT__SPAN + 1])k->given;
        const gifilt__lanes3 p = gifilt__lanes3_load(g[0] + l, g[1] + l, g[2] + l);
        const gifilt__lanes3 n = gifilt__lanes3_load(g[3] + l, g[4] + l, g[5] + l);
        const gifilt__lanes3 next = gifilt__lanes3_load(g[0] + l + 1, g[1] + l + 1, g[2] + l + 1);
        const gifilt__lanes3 d = gifilt__lanes3_sub(next, p);
        const gifilt__lanes d2 = gifilt__lanes3_dot(d, d);
        const gifilt__lanes far2 = gifilt__lanes_add(gifilt__lanes_mul(gifilt__lanes_all(16.0f), d2), least);
        gifilt__lane_mask there = gifilt__mask_and(gifilt__at_most3(p, 1e9f), gifilt__at_most3(n, 1e9f));
        there = gifilt__mask_and(there, gifilt__not_zero(n));
        for (c = 0; c < GIFILT__RGB; c++)
            gifilt__lanes_store(k->now[c] + l, gifilt__lanes_keep(there, gifilt__lanes_load(g[c] + l)));
        for (; c < GIFILT__FRAMES; c++) {
            const gifilt__lanes light = gifilt__lanes_load(g[c] + l);
            const gifilt__lane_mask good = gifilt__mask_and(there, gifilt__at_most(light, GIFILT__MAX_LIGHT));
            gifilt__lanes_store(k->now[c] + l, gifilt__lanes_keep(good, light));
        }
        gifilt__lanes_store(k->size2 + l, gifilt__lanes_select(
            gifilt__lanes_greater(gifilt__lanes_all(1e18f), d2), far2, least));
        gifilt__set_there(k, l, there);
        gifilt__lanes_store(k->now[GIFILT__FRAMES] + l, gifilt__lanes_load(k->there + l));
    }
}

/* Loads pixels x to x + end - 1 of row y, and the place of the pixel after them: the distance between
   neighbours says how far from a pixel the last frame may have seen the same surface, which is four of them.
   */
GIFILT__HOT GIFILT__KERNEL static void gifilt__chunk_load(const gifilt__filter_run *r, gifilt__chunk *k,
                                                          size_t x, size_t y, size_t end)
{
    size_t ps = gifilt__stride(r->points->position_stride, 12) / 4,
           ns = gifilt__stride(r->points->normal_stride, 12) / 4;
    size_t at = y * r->filter->width + x, c;
    const float *p = r->points->positions + ps * at, *n = r->points->normals + ns * at,
                *light = r->in + 3 * at;
    if (end == GIFILT__SPAN && ps == 3 && ns == 3) gifilt__chunk_read(k, p, 3, n, 3, light, GIFILT__SPAN);
    else {
        memset(k->given, 0, sizeof k->given);
        gifilt__chunk_read(k, p, ps, n, ns, light, end);
    }
    for (c = 0; c < 3; c++)
        if (x + end < r->filter->width) k->given[c][end] = p[ps * end + c];
        else k->given[c][end] = end > 1 ? k->given[c][end - 2] : x > 0 ? *(p + c - ps) : p[c];
    gifilt__chunk_set(k);
}

/* Returns 1 if a normal of the chunk is neither unit nor 0 0 0 nor infinite. */
static inline GIFILT__IN_KERNEL int gifilt__chunk_wrong(const gifilt__chunk *k)
{
    int wrong = 0;
    size_t l;
    for (l = 0; l < GIFILT__SPAN; l += GIFILT__LANE_COUNT) {
        const gifilt__lanes3 n = gifilt__lanes3_load(k->given[3] + l, k->given[4] + l, k->given[5] + l);
        const gifilt__lanes length2 = gifilt__lanes3_dot(n, n);
        gifilt__lane_mask bad = gifilt__mask_or(
            gifilt__lanes_greater(gifilt__lanes_all(GIFILT__UNIT_LEAST2), length2),
            gifilt__lanes_greater(length2, gifilt__lanes_all(GIFILT__UNIT_MOST2)));
        bad = gifilt__mask_and(bad, gifilt__not_zero(n));
        bad = gifilt__mask_and(bad, gifilt__at_most(length2, GIFILT__MAX_FLOAT));
        wrong |= gifilt__mask_any(bad);
    }
    return wrong;
}

/* Returns a row of a matrix times places. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__row_times(const float *m, gifilt__lanes3 p)
{
    const gifilt__lanes3 row = gifilt__lanes3_all(m[0], m[4], m[8]);
    return gifilt__lanes_add(gifilt__lanes3_dot(row, p), gifilt__lanes_all(m[12]));
}

/* Finds where in the last frame's picture the pixels' places were, by that frame's matrix. */
GIFILT__HOT GIFILT__KERNEL static void gifilt__chunk_project(const gifilt__filter_run *r, gifilt__chunk *k)
{
    const float *m = r->filter->matrix, up = r->frame->rows == GIFILT_ROWS_TOP_FIRST ? -0.5f : 0.5f;
    const gifilt__lanes width = gifilt__lanes_all((float)r->filter->width), half = gifilt__lanes_all(0.5f);
    const gifilt__lanes height = gifilt__lanes_all((float)r->filter->height), down = gifilt__lanes_all(up);
    size_t l;
    for (l = 0; l < GIFILT__SPAN; l += GIFILT__LANE_COUNT) {
        const gifilt__lanes3 p = gifilt__lanes3_load(k->now[0] + l, k->now[1] + l, k->now[2] + l);
        const gifilt__lanes w = gifilt__row_times(m + 3, p);
        gifilt__lanes x = gifilt__lanes_div(gifilt__row_times(m, p), w);
        gifilt__lanes y = gifilt__lanes_div(gifilt__row_times(m + 1, p), w);
        x = gifilt__lanes_add(half, gifilt__lanes_mul(half, x));
        y = gifilt__lanes_add(half, gifilt__lanes_mul(down, y));
        gifilt__lanes_store(k->x + l, gifilt__lanes_mul(x, width));
        gifilt__lanes_store(k->y + l, gifilt__lanes_mul(y, height));
        gifilt__set_there(k, l, gifilt__mask_and(gifilt__are_there(k, l),
                                                 gifilt__lanes_greater(w, gifilt__lanes_all(0.0f))));
    }
}

/* Marks places that lie no more than a pixel out of the picture. */
static inline GIFILT__IN_KERNEL gifilt__lane_mask gifilt__near_picture(gifilt__lanes x, float size)
{
    return gifilt__mask_and(gifilt__lanes_greater(x, gifilt__lanes_all(-1.0f)),
                            gifilt__lanes_greater(gifilt__lanes_all(size), x));
}

/* Finds between which two pixels places lie, and how far from the first. A place within 1/64 of a pixel's
   centre counts as the centre: a camera that stands still then finds one pixel, not four with weights of
   rounding, and does not blur. */
static inline GIFILT__IN_KERNEL void gifilt__place_axis(gifilt__lane_mask there, const float *place,
                                                        float *pixel, float *between)
{
    const gifilt__lanes eight = gifilt__lanes_all(8.0f);
    gifilt__lanes x = gifilt__lanes_add(gifilt__lanes_load(place), gifilt__lanes_all(7.5f)), centre, whole;
    x = gifilt__lanes_select(there, x, eight);
    centre = gifilt__lanes_of_ints(gifilt__lanes_truncate(gifilt__lanes_add(x, gifilt__lanes_all(0.5f))));
    x = gifilt__lanes_select(gifilt__lanes_greater(gifilt__lanes_all(1.0f / 64.0f),
                                                   gifilt__lanes_abs(gifilt__lanes_sub(x, centre))), centre,
                                                   x);
    whole = gifilt__lanes_of_ints(gifilt__lanes_truncate(x));           /* above 0: this rounds down */
    gifilt__lanes_store(pixel, gifilt__lanes_sub(whole, eight));
    gifilt__lanes_store(between, gifilt__lanes_sub(x, whole));
}

GIFILT__HOT GIFILT__KERNEL static void gifilt__chunk_place(const gifilt__filter_run *r, gifilt__chunk *k)
{
    const float width = (float)r->filter->width + 1.0f, height = (float)r->filter->height + 1.0f;
    size_t l;
    for (l = 0; l < GIFILT__SPAN; l += GIFILT__LANE_COUNT) {
        gifilt__lane_mask there = gifilt__mask_and(gifilt__near_picture(gifilt__lanes_load(k->x + l), width),
                                                   gifilt__near_picture(gifilt__lanes_load(k->y + l),
                                                                        height));
        there = gifilt__mask_and(there, gifilt__are_there(k, l));
        gifilt__set_there(k, l, there);
        gifilt__place_axis(there, k->x + l, k->i + l, k->u + l);
        gifilt__place_axis(there, k->y + l, k->j + l, k->v + l);
    }
}

static inline GIFILT__IN_KERNEL void gifilt__add_to(float *sum, gifilt__lanes a)
{
    gifilt__lanes_store(sum, gifilt__lanes_add(gifilt__lanes_load(sum), a));
}

/* Adds pixels of the last frame, planes t floats apart from q on, for those of the chunk from o on, where
   they show the same surface. */
static inline GIFILT__IN_KERNEL void gifilt__chunk_recall(const gifilt__filter_run *r, gifilt__chunk *k,
                                                          size_t o, const float *q, size_t t,
                                                          gifilt__lanes weight)
{
    const gifilt__shapes now = gifilt__shapes_load(&k->now[0][o], GIFILT__SPAN);
    const gifilt__shapes past = gifilt__shapes_load(q, t);
    const gifilt__lanes3 e = gifilt__lanes3_sub(past.position, now.position);
    const gifilt__lanes frames = gifilt__lanes_load(q + 9 * t), size2 = gifilt__lanes_load(k->size2 + o);
    gifilt__lane_mask nearby = gifilt__lanes_greater(frames, gifilt__lanes_all(0.0f));
    nearby = gifilt__mask_and(nearby, gifilt__lanes_at_least(size2, gifilt__lanes3_dot(e, e)));
    if (r->frame->motion) {
        const gifilt__lanes cosine = gifilt__lanes3_dot(now.normal, past.normal);
        const gifilt__lane_mask same = gifilt__lanes_greater(cosine, gifilt__lanes_all(0.5f));
        weight = gifilt__lanes_mul(gifilt__lanes_keep(same, gifilt__lanes_all(1.0f)), weight);
    } else weight = gifilt__lanes_mul(gifilt__alike(&now, &past, r->limits), weight);
    weight = gifilt__lanes_keep(nearby, weight);
    gifilt__add_to(k->sums[0] + o, gifilt__lanes_mul(weight, gifilt__lanes_load(q + 6 * t)));
    gifilt__add_to(k->sums[1] + o, gifilt__lanes_mul(weight, gifilt__lanes_load(q + 7 * t)));
    gifilt__add_to(k->sums[2] + o, gifilt__lanes_mul(weight, gifilt__lanes_load(q + 8 * t)));
    gifilt__add_to(k->sums[3] + o, gifilt__lanes_mul(weight, frames));
    gifilt__add_to(k->sums[4] + o, weight);
}

