/* ---- kernels of query: one light for many points ---- */

/* The map that answers for all points of a stream, with each number in all lanes. */
typedef struct cohsm__views {
    cohsm__lanes3 center, right, up, back;      /* the sphere's centre; the axes of the map */
    cohsm__lanes per_radius, half, top, bias;   /* 1 / radius; M / 2; M; the query's bias */
    cohsm__lane_ints side, begin, range;        /* M; the first pixel and the number of pixels of the shard */
} cohsm__views;

static inline COHSM__IN_KERNEL cohsm__views cohsm__views_of(const cohsm__stream *s)
{
    const cohsm__header *h = &s->maps->head;
    const cohsm__axes *f = &s->axes;
    cohsm__views v;
    v.center = cohsm__lanes3_all(h->center[0], h->center[1], h->center[2]);
    v.right = cohsm__lanes3_all(f->right.x, f->right.y, f->right.z);
    v.up = cohsm__lanes3_all(f->up.x, f->up.y, f->up.z);
    v.back = cohsm__lanes3_all(f->back.x, f->back.y, f->back.z);
    v.per_radius = cohsm__lanes_all(1.0f / h->radius);
    v.half = cohsm__lanes_all(0.5f * (float)h->map_side);
    v.top = cohsm__lanes_all((float)h->map_side);
    v.bias = cohsm__lanes_all(s->bias);
    v.side = cohsm__ints_all((int32_t)h->map_side);
    v.begin = cohsm__ints_all((int32_t)h->pixel_begin);
    v.range = cohsm__ints_all((int32_t)s->maps->range);
    return v;
}

/* Loads the points from number k on, as many as there are lanes, in radii about the centre; 0 0 0 if there
   are no more. */
static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__stream_load(const cohsm__stream *s, const cohsm__views *v,
                                                                size_t k)
{
    const float *from;
    float last[3 * COHSM__LANE_COUNT];
    size_t i;

    if (!s->packed) return cohsm__lanes3_load(s->x + k, s->y + k, s->z + k);
    from = s->packed + 3 * k;
    for (i = 0; i < 3 * COHSM__LANE_COUNT; i += 16) COHSM__PREFETCH(from + COHSM__AHEAD + i);
    if (s->count - k < COHSM__LANE_COUNT) {
        memset(last, 0, sizeof last);
        memcpy(last, from, 3 * (s->count - k) * sizeof *last);
        from = last;
    }
    return cohsm__lanes3_scale(cohsm__lanes3_sub(cohsm__lanes3_load_packed(from), v->center), v->per_radius);
}

/* Does what cohsm__project_point, cohsm__pixel and cohsm__compared_depth do, for the points from number k on.
   Returns the pixels. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__stream_project(cohsm__stream *s, const cohsm__views *v,
                                                                      size_t k)
{
    const cohsm__lanes3 p = cohsm__stream_load(s, v, k);
    const cohsm__lanes zero = cohsm__lanes_all(0.0f), middle = cohsm__lanes_all(0.5f);
    const cohsm__lanes x =
        cohsm__lanes_add(cohsm__lanes_mul(cohsm__lanes3_dot(p, v->right), v->half), v->half);
    const cohsm__lanes y = cohsm__lanes_add(cohsm__lanes_mul(cohsm__lanes3_dot(p, v->up), v->half), v->half);
    const cohsm__lane_ints none = cohsm__ints_all(-1);      /* COHSM__NO_PIXEL */
    cohsm__lanes d = cohsm__lanes_mul(middle, cohsm__lanes3_dot(p, v->back));
    cohsm__lane_ints pixel;
    cohsm__lane_mask in;

    d = cohsm__lanes_sub(cohsm__lanes_sub(middle, d), v->bias);
    d = cohsm__lanes_mul(d, cohsm__lanes_all((float)COHSM__HIT_MAX));
    in = cohsm__mask_and(cohsm__lanes_at_least(x, zero), cohsm__lanes_greater(v->top, x));
    in = cohsm__mask_and(in, cohsm__mask_and(cohsm__lanes_at_least(y, zero),
                                             cohsm__lanes_greater(v->top, y)));
    in = cohsm__mask_and(in, cohsm__lanes_at_least(d, zero));
    pixel = cohsm__ints_mul(cohsm__lanes_truncate(cohsm__lanes_keep(in, y)), v->side);
    pixel = cohsm__ints_add(pixel, cohsm__lanes_truncate(cohsm__lanes_keep(in, x)));
    pixel = cohsm__ints_sub(pixel, v->begin);
    in = cohsm__mask_and(in, cohsm__ints_greater(pixel, none));
    pixel = cohsm__ints_select(cohsm__mask_and(in, cohsm__ints_greater(v->range, pixel)), pixel, none);
    d = cohsm__lanes_keep(in, cohsm__lanes_min(d, cohsm__lanes_all(65535.0f)));
    cohsm__ints_store(s->pixel + k, pixel);
    cohsm__ints_store(s->depth + k, cohsm__lanes_truncate(d));
    return pixel;
}

/* Does what cohsm__slot does. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__slots(cohsm__lane_ints pixel)
{
    const cohsm__lane_ints high = cohsm__ints_and(cohsm__ints_shift_right(pixel, 3), cohsm__ints_all(0x1f0));
    return cohsm__ints_or(high, cohsm__ints_and(pixel, cohsm__ints_all(15)));
}

/* Finds the pixel and the compared depth of every point. A pixel whose slot holds another pixel takes the
   slot and joins the list of those to be decoded, unless the slot was taken by a pixel of the list already:
   such a slot has the depth -1. */
static inline COHSM__IN_KERNEL void cohsm__stream_find(cohsm__stream *s)
{
    const cohsm__views v = cohsm__views_of(s);
    const cohsm__lane_ints none = cohsm__ints_all(-1);
    cohsm__kept *kept = s->kept;
    size_t k;

    s->listed = 0;
    for (k = 0; k < s->count; k += COHSM__LANE_COUNT) {
        const cohsm__lane_ints pixel = cohsm__stream_project(s, &v, k);
        const cohsm__lane_mask held =
            cohsm__ints_equal(cohsm__ints_gather(kept->pixel, cohsm__slots(pixel)), pixel);
        uint32_t missed =
            cohsm__mask_bits(cohsm__mask_or(held, cohsm__ints_equal(pixel, none))) ^ COHSM__ALL_LANES;
        for (; missed; missed &= missed - 1u) {
            const int32_t wanted = s->pixel[k + cohsm__first_bit(missed)];
            const uint32_t slot = cohsm__slot((uint32_t)wanted);
            if (kept->depth[slot] < 0) continue;
            kept->pixel[slot] = wanted;
            kept->depth[slot] = -1;
            s->list[s->listed++] = (uint32_t)wanted;
        }
    }
}

static inline COHSM__IN_KERNEL void cohsm__stream_decode(cohsm__stream *s)
{
    uint32_t place[COHSM__STEP], i, k, n;
    int32_t depth[COHSM__STEP];

    for (k = 0; k < COHSM__STEP; k++) place[k] = s->place;
    for (i = 0; i < s->listed; i += n) {
        n = cohsm__min_u32(s->listed - i, COHSM__STEP);
        cohsm__find_depths(s->maps, s->list + i, place, n, depth);
        for (k = 0; k < n; k++) s->kept->depth[cohsm__slot(s->list[i + k])] = depth[k];
    }
}

/* Writes the answers of points whose pixels have a slot, and lists the others. */
static inline COHSM__IN_KERNEL void cohsm__stream_compare(cohsm__stream *s, float *visible)
{
    const cohsm__lane_ints one = cohsm__ints_all(1), none = cohsm__ints_all(-1);
    float last[COHSM__LANE_COUNT];
    uint32_t taken;
    size_t k;

    s->listed = 0;
    for (k = 0; k < s->count; k += COHSM__LANE_COUNT) {
        const size_t left = s->count - k;
        const cohsm__lane_ints pixel = cohsm__ints_load(s->pixel + k), slot = cohsm__slots(pixel);
        const cohsm__lane_ints known = cohsm__ints_gather(s->kept->depth, slot);
        const cohsm__lane_mask out = cohsm__ints_equal(pixel, none);
        const cohsm__lane_mask lit =
            cohsm__ints_greater(cohsm__ints_add(known, one), cohsm__ints_load(s->depth + k));
        const cohsm__lane_mask held = cohsm__ints_equal(cohsm__ints_gather(s->kept->pixel, slot), pixel);
        const cohsm__lanes answer = cohsm__lanes_keep(cohsm__mask_or(out, lit), cohsm__lanes_all(1.0f));
        taken = cohsm__mask_bits(cohsm__mask_or(out, held)) ^ COHSM__ALL_LANES;
        if (left >= COHSM__LANE_COUNT) cohsm__lanes_store(visible + k, answer);
        else {
            cohsm__lanes_store(last, answer);
            memcpy(visible + k, last, left * sizeof *last);
            taken &= (1u << left) - 1u;
        }
        for (; taken; taken &= taken - 1u) s->list[s->listed++] = (uint32_t)k + cohsm__first_bit(taken);
    }
}

/* Decodes and answers for the points that are listed. */
static inline COHSM__IN_KERNEL void cohsm__stream_rest(const cohsm__stream *s, float *visible)
{
    uint32_t place[COHSM__STEP], pixel[COHSM__STEP];
    uint32_t i, k, n;
    int32_t depth[COHSM__STEP];

    for (i = 0; i < s->listed; i += n) {
        const uint32_t *at = s->list + i;
        n = cohsm__min_u32(s->listed - i, COHSM__STEP);
        for (k = 0; k < n; k++) {
            pixel[k] = (uint32_t)s->pixel[at[k]];
            place[k] = s->place;
        }
        cohsm__find_depths(s->maps, pixel, place, n, depth);
        for (k = 0; k < n; k++) visible[at[k]] = s->depth[at[k]] > depth[k] ? 0.0f : 1.0f;
    }
}

/* Answers for the points of the stream. */
COHSM__KERNEL static void cohsm__one_light(cohsm__stream *s, float *visible)
{
    cohsm__stream_find(s);
    cohsm__stream_decode(s);
    cohsm__stream_compare(s, visible);
    cohsm__stream_rest(s, visible);
}
