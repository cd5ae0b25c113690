/* ---- kernels of query: one light for many points ---- */

/* The map that answers for all points of a stream, with each number in all lanes. */
typedef struct cohsm__views {
    cohsm__lanes3 center, right, up, back;      /* the sphere's centre; the axes of the map */
    cohsm__lanes3 eye;                          /* of a cube map */
    cohsm__lanes per_radius, half, top, bias;   /* 1 / radius; M / 2; M; the query's bias, in maps */
    cohsm__lanes nearer, deeper;                /* factors of a cube map's depths: bias, range */
    cohsm__lane_ints side, begin, range;        /* M; the first pixel and the number of pixels of the shard */
} cohsm__views;

static inline COHSM__IN_KERNEL cohsm__views cohsm__views_of(const cohsm__stream *s)
{
    const cohsm__header *h = &s->maps->head;
    const cohsm__axes *f = &s->axes;
    const float top = (float)h->map_side;
    cohsm__views v;
    v.center = cohsm__lanes3_all(h->center[0], h->center[1], h->center[2]);
    v.right = cohsm__lanes3_all(f->right.x, f->right.y, f->right.z);
    v.up = cohsm__lanes3_all(f->up.x, f->up.y, f->up.z);
    v.back = cohsm__lanes3_all(f->back.x, f->back.y, f->back.z);
    v.eye = cohsm__lanes3_all(s->eye.x, s->eye.y, s->eye.z);
    v.per_radius = cohsm__lanes_all(1.0f / h->radius);
    v.half = cohsm__lanes_all(0.5f * top);
    v.top = cohsm__lanes_all(top);
    v.bias = cohsm__lanes_all(s->bias / top);
    v.nearer = cohsm__lanes_all(1.0f - 2.0f * s->bias / top);
    v.deeper = cohsm__lanes_all(h->positional ? h->radius / h->depth_far : 0.0f);
    v.side = cohsm__ints_all((int32_t)h->map_side);
    v.begin = cohsm__ints_all((int32_t)h->pixel_begin);
    v.range = cohsm__ints_all((int32_t)s->maps->range);
    return v;
}

/* Loads vectors, which lie `stride` bytes apart, as many as there are lanes; the last of `count` stands for
   those that are missing. */
static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__load_strided(const void *from, size_t stride,
                                                                 size_t count)
{
    float v[3 * COHSM__LANE_COUNT];
    size_t i;
    if (stride == 12 && count >= COHSM__LANE_COUNT)
        return cohsm__lanes3_load_packed((const float *)from);
    if (stride > 12 && count > COHSM__LANE_COUNT) return cohsm__lanes3_load_fours(from, stride);
    for (i = 0; i < COHSM__LANE_COUNT; i++)
        memcpy(v + 3 * i, (const char *)from + stride * (i < count ? i : count - 1), 12);
    return cohsm__lanes3_load_packed(v);
}

/* Loads the points from number k on, as many as there are lanes, in radii about the centre. */
static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__stream_load(const cohsm__stream *s, const cohsm__views *v,
                                                                size_t k)
{
    const char *from;
    size_t i;

    if (!s->points) return cohsm__lanes3_load(s->x + k, s->y + k, s->z + k);
    from = s->points + s->stride * k;
    if (s->stride <= 64)
        for (i = 0; i < COHSM__LANE_COUNT * s->stride; i += 64) COHSM__PREFETCH(from + COHSM__AHEAD + i);
    return cohsm__lanes3_scale(
        cohsm__lanes3_sub(cohsm__load_strided(from, s->stride, s->count - k), v->center), v->per_radius);
}

/* Points as the maps see them: the position in pixels, the depth in 16 bits; `in` are those that are
   finite; face is the number of the cube's face, where the key has it. */
typedef struct cohsm__seen {
    cohsm__lanes x, y, depth;
    cohsm__lane_ints face;
    cohsm__lane_mask in;
} cohsm__seen;

static inline COHSM__IN_KERNEL cohsm__seen cohsm__see_along_axes(const cohsm__views *v, cohsm__lanes3 p)
{
    const cohsm__lanes middle = cohsm__lanes_all(0.5f);
    cohsm__lanes d = cohsm__lanes_mul(middle, cohsm__lanes3_dot(p, v->back));
    cohsm__seen s;
    s.x = cohsm__lanes_add(cohsm__lanes_mul(cohsm__lanes3_dot(p, v->right), v->half), v->half);
    s.y = cohsm__lanes_add(cohsm__lanes_mul(cohsm__lanes3_dot(p, v->up), v->half), v->half);
    d = cohsm__lanes_sub(cohsm__lanes_sub(middle, d), v->bias);
    s.depth = cohsm__lanes_mul(d, cohsm__lanes_all((float)COHSM__HIT_MAX));
    s.face = cohsm__ints_all(0);
    s.in = cohsm__lanes_at_least(s.depth, cohsm__lanes_all(0.0f));  /* what is not finite is outside anyway */
    return s;
}

/* Rounding may leave the face by a hair. */
static inline COHSM__IN_KERNEL cohsm__lanes cohsm__onto_face(const cohsm__views *v, cohsm__lanes x)
{
    const cohsm__lanes zero = cohsm__lanes_all(0.0f), last = cohsm__lanes_sub(v->top, cohsm__lanes_all(0.5f));
    x = cohsm__lanes_select(cohsm__lanes_greater(zero, x), zero, x);
    return cohsm__lanes_select(cohsm__lanes_at_least(x, v->top), last, x);
}

static inline COHSM__IN_KERNEL cohsm__seen cohsm__see_on_face(const cohsm__views *v, cohsm__lanes3 p)
{
    const cohsm__lanes most = cohsm__lanes_all(3.402823466e38f), zero = cohsm__lanes_all(0.0f);
    const cohsm__lanes3 q = cohsm__lanes3_sub(p, v->eye);
    const cohsm__lanes ax = cohsm__lanes_abs(q.x), ay = cohsm__lanes_abs(q.y), az = cohsm__lanes_abs(q.z);
    const cohsm__lane_mask along_x = cohsm__mask_and(cohsm__lanes_at_least(ax, ay),
                                                     cohsm__lanes_at_least(ax, az));
    const cohsm__lane_mask along_y = cohsm__lanes_at_least(ay, az);
    const cohsm__lanes c = cohsm__lanes_select(along_x, q.x, cohsm__lanes_select(along_y, q.y, q.z));
    const cohsm__lanes w = cohsm__lanes_abs(c);
    const cohsm__lane_ints one = cohsm__ints_all(1 << COHSM__KEY_BITS);
    cohsm__seen s;

    s.face = cohsm__ints_select(along_y, cohsm__ints_all(2 << COHSM__KEY_BITS),
                                cohsm__ints_all(4 << COHSM__KEY_BITS));
    s.face = cohsm__ints_select(along_x, cohsm__ints_all(0), s.face);
    s.face = cohsm__ints_add(s.face, cohsm__ints_keep(cohsm__lanes_greater(zero, c), one));
    s.x = cohsm__lanes_select(along_x, q.y, cohsm__lanes_select(along_y, q.z, q.x));
    s.y = cohsm__lanes_select(along_x, q.z, cohsm__lanes_select(along_y, q.x, q.y));
    s.x = cohsm__lanes_add(cohsm__lanes_mul(cohsm__lanes_div(s.x, w), v->half), v->half);
    s.y = cohsm__lanes_add(cohsm__lanes_mul(cohsm__lanes_div(s.y, w), v->half), v->half);
    s.x = cohsm__onto_face(v, s.x);
    s.y = cohsm__onto_face(v, s.y);
    s.depth = cohsm__lanes_mul(cohsm__lanes_mul(w, v->nearer), v->deeper);
    s.depth = cohsm__lanes_mul(s.depth, cohsm__lanes_all((float)COHSM__HIT_MAX));
    s.in = cohsm__mask_and(cohsm__lanes_at_least(s.depth, zero),
                           cohsm__lanes_at_least(most, cohsm__lanes_abs(p.x)));
    s.in = cohsm__mask_and(s.in, cohsm__mask_and(cohsm__lanes_at_least(most, cohsm__lanes_abs(p.y)),
                                                 cohsm__lanes_at_least(most, cohsm__lanes_abs(p.z))));
    return s;
}

/* Does what cohsm__project_point, cohsm__pixel and cohsm__compared_depth do, for the points from number k on.
   Returns the keys. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__stream_project(cohsm__stream *s, const cohsm__views *v,
                                                                      size_t k)
{
    const cohsm__lanes3 p = cohsm__stream_load(s, v, k);
    const cohsm__seen seen =
        s->maps->head.positional ? cohsm__see_on_face(v, p) : cohsm__see_along_axes(v, p);
    const cohsm__lanes zero = cohsm__lanes_all(0.0f);
    const cohsm__lane_ints none = cohsm__ints_all(-1);
    cohsm__lanes d;
    cohsm__lane_ints pixel;
    cohsm__lane_mask in;

    in = cohsm__mask_and(cohsm__lanes_at_least(seen.x, zero), cohsm__lanes_greater(v->top, seen.x));
    in = cohsm__mask_and(in, cohsm__mask_and(cohsm__lanes_at_least(seen.y, zero),
                                             cohsm__lanes_greater(v->top, seen.y)));
    in = cohsm__mask_and(in, seen.in);
    pixel = cohsm__ints_mul(cohsm__lanes_truncate(cohsm__lanes_keep(in, seen.y)), v->side);
    pixel = cohsm__ints_add(pixel, cohsm__lanes_truncate(cohsm__lanes_keep(in, seen.x)));
    pixel = cohsm__ints_sub(pixel, v->begin);
    in = cohsm__mask_and(in, cohsm__ints_greater(pixel, none));
    in = cohsm__mask_and(in, cohsm__ints_greater(v->range, pixel));
    pixel = cohsm__ints_select(in, cohsm__ints_add(pixel, seen.face), none);
    d = cohsm__lanes_keep(in, cohsm__lanes_min(seen.depth, cohsm__lanes_all(65535.0f)));
    cohsm__ints_store(s->key + k, pixel);
    cohsm__ints_store(s->depth + k, cohsm__lanes_truncate(d));
    return pixel;
}

/* Does what cohsm__slot does. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__slots(cohsm__lane_ints key)
{
    const cohsm__lane_ints high = cohsm__ints_and(cohsm__ints_shift_right(key, 3), cohsm__ints_all(0x1f0));
    return cohsm__ints_or(high, cohsm__ints_and(key, cohsm__ints_all(15)));
}

/* Finds the key and the compared depth of every point. A key whose slot holds another one takes the slot and
   joins the list of those to be decoded, unless the slot was taken by a key of the list already: such a slot
   has the depth -1. */
static inline COHSM__IN_KERNEL void cohsm__stream_find(cohsm__stream *s)
{
    const cohsm__views v = cohsm__views_of(s);
    const cohsm__lane_ints none = cohsm__ints_all(-1);
    cohsm__kept *kept = s->kept;
    size_t k;

    s->listed = 0;
    for (k = 0; k < s->count; k += COHSM__LANE_COUNT) {
        const cohsm__lane_ints key = cohsm__stream_project(s, &v, k);
        const cohsm__lane_mask held =
            cohsm__ints_equal(cohsm__ints_gather(kept->key, cohsm__slots(key)), key);
        uint32_t missed =
            cohsm__mask_bits(cohsm__mask_or(held, cohsm__ints_equal(key, none))) ^ COHSM__ALL_LANES;
        for (; missed; missed &= missed - 1u) {
            const int32_t wanted = s->key[k + cohsm__first_bit(missed)];
            const uint32_t slot = cohsm__slot((uint32_t)wanted);
            if (kept->depth[slot] < 0) continue;
            kept->key[slot] = wanted;
            kept->depth[slot] = -1;
            s->list[s->listed++] = (uint32_t)wanted;
        }
    }
}

/* Decodes the depths of up to a step of keys; those behind the last are read as far as lanes go. */
static inline COHSM__IN_KERNEL void cohsm__keys_decode(const cohsm__stream *s, const uint32_t *key,
                                                       uint32_t count, int32_t *depth)
{
    const cohsm__lane_ints low = cohsm__ints_all((1 << COHSM__KEY_BITS) - 1);
    const cohsm__lane_ints first = cohsm__ints_all((int32_t)s->place);
    const cohsm__lane_ints maps = cohsm__ints_all((int32_t)s->maps->head.map_count);
    uint32_t k;
    int32_t pixel[COHSM__STEP], place[COHSM__STEP];

    for (k = 0; k < count; k += COHSM__LANE_COUNT) {
        const cohsm__lane_ints all = cohsm__ints_load((const int32_t *)(const void *)(key + k));
        const cohsm__lane_ints face = cohsm__ints_shift_right(all, COHSM__KEY_BITS);
        cohsm__ints_store(pixel + k, cohsm__ints_and(all, low));
        cohsm__ints_store(place + k, cohsm__ints_add(first, cohsm__ints_mul(face, maps)));
    }
    cohsm__find_depths(s->maps, (const uint32_t *)pixel, (const uint32_t *)place, count, depth);
}

static inline COHSM__IN_KERNEL void cohsm__stream_decode(cohsm__stream *s)
{
    uint32_t i, k, n;
    int32_t depth[COHSM__STEP];

    for (i = 0; i < s->listed; i += n) {
        n = cohsm__min_u32(s->listed - i, COHSM__STEP);
        cohsm__keys_decode(s, s->list + i, n, depth);
        for (k = 0; k < n; k++) s->kept->depth[cohsm__slot(s->list[i + k])] = depth[k];
    }
}

/* Writes the answers of points whose keys have a slot, and lists the others. */
static inline COHSM__IN_KERNEL void cohsm__stream_compare(cohsm__stream *s, float *visible)
{
    const cohsm__lane_ints one = cohsm__ints_all(1), none = cohsm__ints_all(-1);
    float last[COHSM__LANE_COUNT];
    uint32_t taken;
    size_t k;

    s->listed = 0;
    for (k = 0; k < s->count; k += COHSM__LANE_COUNT) {
        const size_t left = s->count - k;
        const cohsm__lane_ints key = cohsm__ints_load(s->key + k), slot = cohsm__slots(key);
        const cohsm__lane_ints known = cohsm__ints_gather(s->kept->depth, slot);
        const cohsm__lane_mask out = cohsm__ints_equal(key, none);
        const cohsm__lane_mask lit =
            cohsm__ints_greater(cohsm__ints_add(known, one), cohsm__ints_load(s->depth + k));
        const cohsm__lane_mask held = cohsm__ints_equal(cohsm__ints_gather(s->kept->key, slot), key);
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
    uint32_t key[COHSM__STEP] = { 0 }, i, k, n;
    int32_t depth[COHSM__STEP];

    for (i = 0; i < s->listed; i += n) {
        const uint32_t *at = s->list + i;
        n = cohsm__min_u32(s->listed - i, COHSM__STEP);
        for (k = 0; k < n; k++) key[k] = (uint32_t)s->key[at[k]];
        cohsm__keys_decode(s, key, n, depth);
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
