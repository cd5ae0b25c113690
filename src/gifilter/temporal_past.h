/* ---- kernels: pixels of the last frame ---- */

/* Writes the least of `low` and the greatest of `high` over all lanes. */
static inline GIFILT__IN_KERNEL void gifilt__range_of(gifilt__lanes low, gifilt__lanes high, int32_t *least,
                                                      int32_t *greatest)
{
    float lows[GIFILT__LANE_COUNT], highs[GIFILT__LANE_COUNT];
    int l;
    gifilt__lanes_store(lows, low);
    gifilt__lanes_store(highs, high);
    for (l = 1; l < GIFILT__LANE_COUNT; l++) {
        lows[0] = lows[l] < lows[0] ? lows[l] : lows[0];
        highs[0] = highs[l] > highs[0] ? highs[l] : highs[0];
    }
    *least = (int32_t)lows[0];
    *greatest = (int32_t)highs[0];
}

/* Finds which columns, less the pixels' own numbers, and rows of the last frame `count` pixels from o on were
   at. Returns -1 if none of them was seen, 1 if they lay in a row as they do now, but for one column or row
   more or less, and 0 if they did not. */
static inline GIFILT__IN_KERNEL int gifilt__chunk_range(const gifilt__chunk *k, size_t o, size_t count,
                                                        int32_t low[2], int32_t high[2])
{
    const gifilt__lanes most = gifilt__lanes_all(16777216.0f), least = gifilt__lanes_all(-16777216.0f);
    const gifilt__lanes numbers = gifilt__lanes_load(gifilt__numbers);
    gifilt__lanes a = most, b = least, c = most, d = least;
    size_t l;
    for (l = o; l < o + count; l += GIFILT__LANE_COUNT) {
        const gifilt__lane_mask there = gifilt__are_there(k, l);
        const gifilt__lanes own = gifilt__lanes_add(numbers, gifilt__lanes_all((float)l));
        const gifilt__lanes i = gifilt__lanes_sub(gifilt__lanes_load(k->i + l), own);
        const gifilt__lanes j = gifilt__lanes_load(k->j + l);
        a = gifilt__lanes_min(gifilt__lanes_select(there, i, most), a);
        b = gifilt__lanes_max(gifilt__lanes_select(there, i, least), b);
        c = gifilt__lanes_min(gifilt__lanes_select(there, j, most), c);
        d = gifilt__lanes_max(gifilt__lanes_select(there, j, least), d);
    }
    gifilt__range_of(a, b, &low[0], &high[0]);
    gifilt__range_of(c, d, &low[1], &high[1]);
    return low[0] > high[0] ? -1 : high[0] - low[0] <= 1 && high[1] - low[1] <= 1;
}

/* Returns the bilinear weight of a pixel that lies d pixels after the first of two for a place at u between
   them; if d is neither 0 nor 1, takes the lane out of *one. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__share(gifilt__lanes d, gifilt__lanes u,
                                                            gifilt__lane_mask *one)
{
    const gifilt__lanes zero = gifilt__lanes_all(0.0f), last = gifilt__lanes_all(1.0f);
    *one = gifilt__mask_and(*one, gifilt__lanes_at_least(d, zero));
    *one = gifilt__mask_and(*one, gifilt__lanes_at_least(last, d));
    return gifilt__lanes_select(gifilt__lanes_differ(d, zero), u, gifilt__lanes_sub(last, u));
}

/* Adds runs of the last frame's pixels, at most 3 x 3: columns and rows from low to one after high. */
static inline GIFILT__IN_KERNEL void gifilt__past_runs(const gifilt__filter_run *r, gifilt__chunk *k,
                                                       size_t o, const int32_t low[2], const int32_t high[2])
{
    const gifilt_filter *f = r->filter;
    const gifilt__lanes numbers = gifilt__lanes_load(gifilt__numbers), rows = gifilt__lanes_load(k->j + o);
    const gifilt__lanes own = gifilt__lanes_add(numbers, gifilt__lanes_all((float)o));
    const gifilt__lanes column = gifilt__lanes_sub(own, gifilt__lanes_load(k->i + o));
    int32_t i, j;
    for (j = low[1]; j <= high[1] + 1; j++)
        for (i = low[0]; i <= high[0] + 1; i++) {
            const gifilt__lanes dx = gifilt__lanes_add(gifilt__lanes_all((float)i), column);
            const gifilt__lanes dy = gifilt__lanes_sub(gifilt__lanes_all((float)j), rows);
            gifilt__lane_mask one = gifilt__are_there(k, o);
            gifilt__lanes weight = gifilt__share(dx, gifilt__lanes_load(k->u + o), &one);
            weight = gifilt__lanes_mul(weight, gifilt__share(dy, gifilt__lanes_load(k->v + o), &one));
            weight = gifilt__lanes_keep(one, weight);
            if (gifilt__mask_any(gifilt__lanes_greater(weight, gifilt__lanes_all(0.0f))) && j >= 0 &&
                j < (int32_t)f->height) {
                const float *row = f->history + (size_t)j * GIFILT__PLANES * f->spacing;
                gifilt__chunk_recall(r, k, o, row + (i + (int32_t)o), f->spacing, weight);
            }
        }
}

/* Adds the four pixels of the last frame about each place, fetched one by one. */
static inline GIFILT__IN_KERNEL void gifilt__past_each(const gifilt__filter_run *r, gifilt__chunk *k,
                                                       size_t o)
{
    const gifilt_filter *f = r->filter;
    float room[GIFILT__PLANES][GIFILT__LANE_COUNT], weights[GIFILT__LANE_COUNT];
    size_t l, c;
    int32_t n;
    for (n = 0; n < 4; n++) {
        for (l = 0; l < GIFILT__LANE_COUNT; l++) {
            const int32_t x = (int32_t)k->i[o + l] + (n & 1), y = (int32_t)k->j[o + l] + (n >> 1);
            const int inside = k->there[o + l] > 0.0f && x >= 0 && y >= 0 && x < (int32_t)f->width &&
                               y < (int32_t)f->height;
            const float *q = inside ? f->history + (size_t)y * GIFILT__PLANES * f->spacing + (size_t)x : NULL;
            weights[l] =
                (n & 1 ? k->u[o + l] : 1.0f - k->u[o + l]) * (n & 2 ? k->v[o + l] : 1.0f - k->v[o + l]);
            for (c = 0; c < GIFILT__PLANES; c++) room[c][l] = q ? q[c * f->spacing] : 0.0f;
        }
        gifilt__chunk_recall(r, k, o, room[0], GIFILT__LANE_COUNT, gifilt__lanes_load(weights));
    }
}

/* Sums the four pixels of the last frame about each place, with bilinear weights. If neighbours were
   neighbours then, but for one column or row, as in most chunks, whole runs of pixels are read; otherwise
   each pixel is fetched alone. */
GIFILT__HOT GIFILT__KERNEL static void gifilt__chunk_past(const gifilt__filter_run *r, gifilt__chunk *k)
{
    int32_t low[2], high[2];
    size_t o;
    int whole = gifilt__chunk_range(k, 0, GIFILT__SPAN, low, high), run = whole;
    memset(k->sums, 0, sizeof k->sums);
    for (o = 0; o < GIFILT__SPAN && whole >= 0; o += GIFILT__LANE_COUNT) {
        if (!whole) run = gifilt__chunk_range(k, o, GIFILT__LANE_COUNT, low, high);
        if (run > 0) gifilt__past_runs(r, k, o, low, high);
        else if (run == 0) gifilt__past_each(r, k, o);
    }
}

/* Mixes what the last frames knew into what this one sees. */
GIFILT__HOT GIFILT__KERNEL static void gifilt__chunk_blend(gifilt__chunk *k, float history)
{
    const gifilt__lanes least = gifilt__lanes_all(0.01f), zero = gifilt__lanes_all(0.0f);
    size_t l, c;
    for (l = 0; l < GIFILT__SPAN; l += GIFILT__LANE_COUNT) {
        const gifilt__lanes weights = gifilt__lanes_load(k->sums[4] + l);
        const gifilt__lanes past = gifilt__lanes_load(k->sums[3] + l);
        const gifilt__lanes sum = gifilt__lanes_max(weights, least);
        const gifilt__lanes more = gifilt__lanes_add(gifilt__lanes_div(past, sum), gifilt__lanes_all(1.0f));
        const gifilt__lanes frames = gifilt__lanes_min(more, gifilt__lanes_all(history));
        const gifilt__lane_mask there = gifilt__mask_and(gifilt__lanes_greater(weights, least),
                                                         gifilt__lanes_greater(past, zero));
        float *own = k->now[GIFILT__FRAMES] + l;
        gifilt__set_there(k, l, there);
        for (c = 0; c < 3; c++) {
            const gifilt__lanes now = gifilt__lanes_load(k->now[GIFILT__RGB + c] + l);
            const gifilt__lanes old = gifilt__lanes_div(gifilt__lanes_load(k->sums[c] + l), sum);
            const gifilt__lanes step = gifilt__lanes_div(gifilt__lanes_sub(now, old), frames);
            gifilt__lanes_store(k->now[GIFILT__RGB + c] + l,
                                gifilt__lanes_select(there, gifilt__lanes_add(old, step), now));
        }
        gifilt__lanes_store(own, gifilt__lanes_select(there, frames, gifilt__lanes_load(own)));
    }
}

GIFILT__HOT GIFILT__KERNEL static void gifilt__accumulate(const gifilt__filter_run *r, size_t y)
{
    const float *motion = r->frame->motion;
    size_t x, c, l;
    size_t width = r->filter->width, s = r->filter->spacing;
    gifilt__chunk k;
    int wrong = 0;
    for (x = 0; x < width; x += GIFILT__SPAN) {
        size_t end = width - x < GIFILT__SPAN ? width - x : (size_t)GIFILT__SPAN;
        float *to = r->filter->next + y * GIFILT__PLANES * s + x;
        gifilt__chunk_load(r, &k, x, y, end);
        wrong |= gifilt__chunk_wrong(&k);
        /* A surface that moved may be any distance from its old place. */
        for (l = 0; motion && l < GIFILT__SPAN; l++) {
            k.x[l] = l < end ? motion[2 * (y * width + x + l)] : 0.0f;
            k.y[l] = l < end ? motion[2 * (y * width + x + l) + 1] : 0.0f;
            k.size2[l] = GIFILT__FAR;
        }
        if (r->recalls) {
            /* Most cameras move little: the next row is wanted next. */
            for (l = 0; y + 1 < r->filter->height && l < end; l += GIFILT__WIDE)
                gifilt__fetch_ahead(r->filter->history + (y + 1) * GIFILT__PLANES * s + x + l, s,
                                    GIFILT__PLANES);
            if (!motion) gifilt__chunk_project(r, &k);
            gifilt__chunk_place(r, &k);
            gifilt__chunk_past(r, &k);
            gifilt__chunk_blend(&k, (float)r->history);
        }
        for (c = 0; c < GIFILT__PLANES; c++)
            if (end == GIFILT__SPAN) memcpy(to + c * s, k.now[c], sizeof k.now[c]);
            else memcpy(to + c * s, k.now[c], end * sizeof *to); /* margins stay 0 */
    }
    r->filter->wrong_rows[y] = (uint8_t)wrong;
}
