/* ---- scenes: which occluders lie near ---- */

/* Occluders lie along a Morton curve, and four in a row that begin at a multiple of four, sixteen, and so on,
   have a sphere about all that they reach. Whoever looks for occluders walks past those whose sphere is far
   away, so that scenes of many bodies cost what lies near a point. It finds all that matter, and others: the
   exact tests come after it. */

/* Sorts a, which is n numbers long, by way of b. Returns where the result is, a or b. */
static uint64_t *sfield__sort_keys(uint64_t *a, uint64_t *b, uint32_t n)
{
    uint32_t width, i, end;
    for (width = 1; width < n; width *= 2) {
        uint64_t *swap = a;
        for (i = 0; i < n; i += 2 * width) {
            const uint32_t middle = n - i < width ? n : i + width;
            uint32_t j = i, k = middle;
            end = n - middle < width ? n : middle + width;
            for (; j < middle || k < end; b++)
                *b = k == end || (j < middle && a[j] < a[k]) ? a[j++] : a[k++];
        }
        a = b - n;
        b = swap;
    }
    return a;
}

/* Finds a sphere about all that some occluders reach. */
static sfield__ball sfield__bound_reach(const sfield_scene *s, const uint64_t *order, uint32_t count)
{
    sfield__ball ball = { { 0, 0, 0 }, 0 };
    uint32_t i, k;
    for (k = 0; k < 3; k++) {
        float low = s->item[(uint32_t)order[0]].center[0][k], high = low;
        for (i = 1; i < count; i++) {
            const float x = s->item[(uint32_t)order[i]].center[0][k];
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        ball.center[k] = 0.5f * low + 0.5f * high;
    }
    for (i = 0; i < count; i++) {
        const sfield__item *it = &s->item[(uint32_t)order[i]];
        const sfield__v3 c = sfield__v3_load(it->center[0]);
        const float r = it->reach + sfield__v3_length(sfield__v3_sub(c, sfield__v3_load(ball.center)));
        ball.radius = r <= ball.radius ? ball.radius : r;       /* no number: never far */
    }
    return ball;
}

/* Writes the place along a Morton curve of each occluder's center, and below it which it is. */
static void sfield__place_on_curve(const sfield_scene *s, uint64_t *key)
{
    uint32_t i, k, b;
    for (i = 0; i < s->occluder_count; i++) key[i] = s->occluder[i];
    for (k = 0; k < 3; k++) {
        float low = 3e38f, high = -3e38f, scale;
        for (i = 0; i < s->occluder_count; i++) {
            const float x = s->item[s->occluder[i]].center[0][k];
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        scale = high > low ? 1023 / (high - low) : 0;
        for (i = 0; i < s->occluder_count; i++) {
            const float x = (s->item[s->occluder[i]].center[0][k] - low) * scale;
            const uint32_t at = x > 0 ? x < 1023 ? (uint32_t)x : 1023u : 0u;
            for (b = 0; b < 10; b++) key[i] |= (uint64_t)(at >> b & 1u) << (32 + 3 * b + k);
        }
    }
}

/* Makes the spheres of a scene whose items are there. Returns 0 if there is no memory. */
static int sfield__make_tree(sfield_scene *s)
{
    sfield__tree *t = &s->tree;
    const uint32_t n = t->count = s->occluder_count;
    uint32_t i, k, balls = 0;
    for (t->levels = 0; (4u << 2 * t->levels) < n; t->levels++)
        balls += (n + (4u << 2 * t->levels) - 1) >> (2 * t->levels + 2);
    t->keys = (uint64_t *)sfield__alloc_array(&s->allocator, n ? n : 1, 2 * sizeof *t->keys);
    t->ball = (sfield__ball *)sfield__alloc_array(&s->allocator, balls ? balls : 1, sizeof *t->ball);
    if (!t->keys || !t->ball) return 0;
    sfield__place_on_curve(s, t->keys);
    t->order = sfield__sort_keys(t->keys, t->keys + n, n);
    for (k = 0, balls = 0; k < t->levels; k++) {
        const uint32_t size = 4u << 2 * k;
        t->level[k] = t->ball + balls;
        for (i = 0; i < n; i += size)
            t->ball[balls++] = sfield__bound_reach(s, t->order + i, n - i < size ? n - i : size);
    }
    return 1;
}

static void sfield__start_walk(sfield__walk *w, const sfield_scene *s, const float *middle, float extent)
{
    w->tree = &s->tree;
    memcpy(w->middle, middle, sizeof w->middle);
    w->extent = extent;
    w->at = 0;
    w->level = s->tree.levels;
}

/* Returns the next occluder, by its item, that may reach a sphere, or SFIELD__NONE after the last. What it
   walks past is too far away for sure, by more than what roundings come to. */
static uint32_t sfield__next_near(sfield__walk *w)
{
    const sfield__tree *t = w->tree;
    while (w->at < t->count) {
        const uint32_t at = w->at, level = w->level;
        if (level) {
            const sfield__ball *b = &t->level[level - 1][at >> 2 * level];
            const float x = b->center[0] - w->middle[0], y = b->center[1] - w->middle[1];
            const float z = b->center[2] - w->middle[2], r = 1.0001f * (b->radius + w->extent) + 1e-18f;
            if (!(x * x + y * y + z * z > r * r)) {
                w->level--;
                continue;
            }
        }
        w->at += 1u << 2 * level;
        while (w->level < t->levels && !(w->at & ((4u << 2 * w->level) - 1))) w->level++;
        if (!level) return (uint32_t)t->order[at];
    }
    return SFIELD__NONE;
}
