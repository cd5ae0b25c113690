/* ---- kernels of raster: which triangles of a slab are drawn ---- */

/* Returns where sample number n of a row or column lies, in 1/256 pixel. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__sample_middle(cohsm__lane_ints n)
{
    return cohsm__ints_add(cohsm__ints_mul(n, cohsm__ints_all(COHSM__SUBPIXEL)),
                           cohsm__ints_all(COHSM__SUBPIXEL / 2));
}

/* Loads one corner of as many triangles as there are lanes, from rows of x, y and z that lie COHSM__CLUSTER
   floats apart. */
static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__corner_load(const float *v)
{
    return cohsm__lanes3_load(v, v + COHSM__CLUSTER, v + 2 * COHSM__CLUSTER);
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__fixed(cohsm__lanes3 corner, cohsm__lanes3 axis,
                                                             cohsm__lanes offset)
{
    return cohsm__lanes_truncate(cohsm__lanes_add(cohsm__lanes3_dot(corner, axis), offset));
}

static inline COHSM__IN_KERNEL cohsm__lanes cohsm__depths(cohsm__lanes3 corner, cohsm__lanes3 half_back)
{
    return cohsm__lanes_sub(cohsm__lanes_all(0.5f), cohsm__lanes3_dot(corner, half_back));
}

/* Appends the triangles of a mask to those of the queue. */
static inline COHSM__IN_KERNEL void cohsm__queue_add(cohsm__queue *q, const cohsm__triangles *p,
                                                     cohsm__lane_mask m)
{
    const uint32_t at = q->count;
    cohsm__ints_append(q->x[0] + at, m, p->x0);
    cohsm__ints_append(q->x[1] + at, m, p->x1);
    cohsm__ints_append(q->x[2] + at, m, p->x2);
    cohsm__ints_append(q->y[0] + at, m, p->y0);
    cohsm__ints_append(q->y[1] + at, m, p->y1);
    cohsm__ints_append(q->y[2] + at, m, p->y2);
    cohsm__lanes_append(q->z[0] + at, m, p->z0);
    cohsm__lanes_append(q->z[1] + at, m, p->z1);
    cohsm__lanes_append(q->z[2] + at, m, p->z2);
    q->count = at + cohsm__mask_count(m);
}

/* The axes of an orthographic view, for positions on its image in 1/256 pixel from its lower left corner. */
typedef struct cohsm__image_axes {
    cohsm__lanes3 right, up, half_back;
    cohsm__lanes offset;
} cohsm__image_axes;

static inline COHSM__IN_KERNEL cohsm__image_axes cohsm__image_axes_of(const cohsm__target *t,
                                                                      const cohsm__axes *axes)
{
    const float scale = (float)(t->size * (COHSM__SUBPIXEL / 2));
    const cohsm__v3 r = cohsm__v3_scale(axes->right, scale), u = cohsm__v3_scale(axes->up, scale);
    cohsm__image_axes a;
    a.right = cohsm__lanes3_all(r.x, r.y, r.z);
    a.up = cohsm__lanes3_all(u.x, u.y, u.z);
    a.half_back = cohsm__lanes3_all(0.5f * axes->back.x, 0.5f * axes->back.y, 0.5f * axes->back.z);
    a.offset = cohsm__lanes_all(scale + 0.5f);
    return a;
}

/* Appends one corner of the triangles of a mask to number k of those of the slab. */
static inline COHSM__IN_KERNEL void cohsm__slab_corner(cohsm__slab *slab, int k, cohsm__lane_mask m,
                                                       const cohsm__lanes3 *corner, cohsm__lane_ints x,
                                                       cohsm__lane_ints middle)
{
    const uint32_t at = slab->count;
    cohsm__ints_append(slab->x[k] + at, m, x);
    cohsm__ints_append(slab->off[k] + at, m, cohsm__ints_sub(x, middle));
    cohsm__lanes_append(slab->corner[3 * k] + at, m, corner->x);
    cohsm__lanes_append(slab->corner[3 * k + 1] + at, m, corner->y);
    cohsm__lanes_append(slab->corner[3 * k + 2] + at, m, corner->z);
}

/* Appends the triangles that hold a sample column to those of the slab, with x of their corners. */
static inline COHSM__IN_KERNEL void cohsm__slab_add(cohsm__slab *slab, const cohsm__target *t,
                                                    const cohsm__image_axes *axes,
                                                    const cohsm__lanes3 *corner)
{
    const cohsm__lane_ints x0 = cohsm__fixed(corner[0], axes->right, axes->offset);
    const cohsm__lane_ints x1 = cohsm__fixed(corner[1], axes->right, axes->offset);
    const cohsm__lane_ints x2 = cohsm__fixed(corner[2], axes->right, axes->offset);
    cohsm__lane_ints low, high, middle, column;
    cohsm__lane_mask m;

    cohsm__span(x0, x1, x2, &low, &high);
    m = cohsm__span_meets(low, high, 0, t->size);
    middle = cohsm__sample_middle(low);
    column = cohsm__ints_select(cohsm__ints_equal(low, high), low, cohsm__ints_all(-1));
    cohsm__ints_append(slab->column + slab->count, m, column);
    cohsm__slab_corner(slab, 0, m, corner, x0, middle);
    cohsm__slab_corner(slab, 1, m, corner + 1, x1, middle);
    cohsm__slab_corner(slab, 2, m, corner + 2, x2, middle);
    slab->count += cohsm__mask_count(m);
}

/* Asks for the triangles of a part of a cluster, as many as there are lanes: what all views of a column read
   once does not stay in a cache. */
static inline COHSM__IN_KERNEL void cohsm__prefetch_part(const cohsm__soup *soup, uint32_t cluster,
                                                         uint32_t part)
{
    enum { FLOATS = 9 * COHSM__LANE_COUNT };
    const float *v = cohsm__cluster(soup, cluster) + FLOATS * part;
    int k;
    for (k = 0; k < FLOATS; k += 16) COHSM__PREFETCH(v + k);
}

/* Finds the triangles of a slab's clusters, which stand from `first` on in the list, that hold a sample
   column of all views with the right axis of this one. */
COHSM__KERNEL static void cohsm__find_slab(const cohsm__target *t, const cohsm__camera *cam,
                                            const cohsm__soup *soup, const cohsm__sight *sight,
                                            uint32_t first, cohsm__slab *slab)
{
    enum { PARTS = COHSM__CLUSTER / COHSM__LANE_COUNT };
    const cohsm__image_axes axes = cohsm__image_axes_of(t, &cam->axes);
    const uint32_t last = sight->count - 1u;
    const uint32_t end = cohsm__min_u32(first + (uint32_t)COHSM__SLAB / COHSM__CLUSTER, sight->count);
    uint32_t i;

    slab->count = 0;
    for (i = PARTS * first; i < PARTS * end; i++) {
        const float *v = cohsm__cluster(soup, sight->cluster[i / PARTS]) + COHSM__LANE_COUNT * (i % PARTS);
        const uint32_t ahead = cohsm__min_u32(i / PARTS + (uint32_t)COHSM__CLUSTERS_AHEAD, last);
        cohsm__lanes3 corner[3];
        cohsm__prefetch_part(soup, sight->cluster[ahead], i % PARTS);
        corner[0] = cohsm__corner_load(v);
        corner[1] = cohsm__corner_load(v + 3 * COHSM__CLUSTER);
        corner[2] = cohsm__corner_load(v + 6 * COHSM__CLUSTER);
        cohsm__slab_add(slab, t, &axes, corner);
    }
}

/* Appends the triangles of a mask to the specks, by y and depths of p; row is that of their samples. */
static inline COHSM__IN_KERNEL void cohsm__specks_add(const cohsm__target *t, const cohsm__slab *slab,
                                                      uint32_t from, const cohsm__triangles *p,
                                                      cohsm__lane_ints row, cohsm__lane_mask m,
                                                      cohsm__specks *s)
{
    const uint32_t at = s->count;
    const cohsm__lane_ints middle = cohsm__sample_middle(row), column = cohsm__ints_load(slab->column + from);
    const cohsm__lane_ints y0 = cohsm__ints_sub(p->y0, middle), y1 = cohsm__ints_sub(p->y1, middle);
    const cohsm__lane_ints y2 = cohsm__ints_sub(p->y2, middle);

    cohsm__ints_append(s->corner[0] + at, m,
                       cohsm__ints_join_halves(cohsm__ints_load(slab->off[0] + from), y0));
    cohsm__ints_append(s->corner[1] + at, m,
                       cohsm__ints_join_halves(cohsm__ints_load(slab->off[1] + from), y1));
    cohsm__ints_append(s->corner[2] + at, m,
                       cohsm__ints_join_halves(cohsm__ints_load(slab->off[2] + from), y2));
    cohsm__lanes_append(s->z[0] + at, m, p->z0);
    cohsm__lanes_append(s->z[1] + at, m, p->z1);
    cohsm__lanes_append(s->z[2] + at, m, p->z2);
    cohsm__ints_append(s->pixel + at, m,
                       cohsm__ints_add(cohsm__ints_mul(row, cohsm__ints_all(t->size)), column));
    s->count = at + cohsm__mask_count(m);
}

static inline COHSM__IN_KERNEL cohsm__lanes3 cohsm__slab_load(const cohsm__slab *slab, int k, uint32_t at)
{
    return cohsm__lanes3_load(slab->corner[3 * k] + at, slab->corner[3 * k + 1] + at,
                              slab->corner[3 * k + 2] + at);
}

/* Puts those triangles of a slab, from number at on, as many as there are lanes or are left, into the queue
   of a view that hold a sample row, or among its specks. */
static inline COHSM__IN_KERNEL void cohsm__enqueue_some(const cohsm__target *t,
                                                        const cohsm__image_axes *axes,
                                                        const cohsm__slab *slab, uint32_t at, cohsm__queue *q)
{
    const cohsm__lane_ints left = cohsm__ints_all((int32_t)(slab->count - at)), minus = cohsm__ints_all(-1);
    cohsm__lane_mask use = cohsm__ints_greater(left, cohsm__ints_load(cohsm__numbers)), speck;
    const cohsm__lanes3 corner0 = cohsm__slab_load(slab, 0, at), corner1 = cohsm__slab_load(slab, 1, at);
    const cohsm__lanes3 corner2 = cohsm__slab_load(slab, 2, at);
    cohsm__lane_ints low, high, column;
    cohsm__triangles p;

    p.y0 = cohsm__fixed(corner0, axes->up, axes->offset);
    p.y1 = cohsm__fixed(corner1, axes->up, axes->offset);
    p.y2 = cohsm__fixed(corner2, axes->up, axes->offset);
    p.z0 = cohsm__depths(corner0, axes->half_back);
    p.z1 = cohsm__depths(corner1, axes->half_back);
    p.z2 = cohsm__depths(corner2, axes->half_back);
    cohsm__span(p.y0, p.y1, p.y2, &low, &high);
    use = cohsm__mask_and(use, cohsm__span_meets(low, high, t->row_begin, t->row_end));
    column = cohsm__ints_select(cohsm__ints_equal(low, high), cohsm__ints_load(slab->column + at), minus);
    speck = cohsm__mask_and(use, cohsm__ints_greater(column, minus));
    if (cohsm__mask_any(speck)) cohsm__specks_add(t, slab, at, &p, low, speck, &q->specks);
    use = cohsm__mask_and(use, cohsm__ints_equal(column, minus));
    if (!cohsm__mask_any(use)) return;
    p.x0 = cohsm__ints_load(slab->x[0] + at);
    p.x1 = cohsm__ints_load(slab->x[1] + at);
    p.x2 = cohsm__ints_load(slab->x[2] + at);
    cohsm__queue_add(q, &p, use);
}

/* Puts the triangles of a slab into the queue of one of its views. */
COHSM__KERNEL static void cohsm__enqueue_slab(const cohsm__target *t, const cohsm__camera *cam,
                                              const cohsm__slab *slab, cohsm__queue *q)
{
    const cohsm__image_axes axes = cohsm__image_axes_of(t, &cam->axes);
    uint32_t at;

    for (at = 0; at < slab->count; at += COHSM__LANE_COUNT) {
        cohsm__enqueue_some(t, &axes, slab, at, q);
        if (q->count > COHSM__MANY || q->specks.count > COHSM__MANY) cohsm__draw_queue(t, cam, q, 0);
    }
}

#if COHSM__LANE_COUNT == 8

/* Says which of 8 clusters may cover samples of the wanted rows. Rounding moves corners by less than a
   hundredth of a pixel. */
static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__sees8(const cohsm__target *t, cohsm__v3 up,
                                                             const float *box)
{
    const cohsm__lanes half = cohsm__lanes_all(0.5f * (float)t->size), one = cohsm__lanes_all(1.0f);
    const cohsm__lanes3 middle = cohsm__lanes3_load(box, box + 8, box + 16);
    const cohsm__lanes3 side = cohsm__lanes3_load(box + 24, box + 32, box + 40);
    cohsm__lanes y = cohsm__lanes3_dot(middle, cohsm__lanes3_all(up.x, up.y, up.z));
    cohsm__lanes e = cohsm__lanes3_dot(side, cohsm__lanes3_all(fabsf(up.x), fabsf(up.y), fabsf(up.z)));
    y = cohsm__lanes_mul(cohsm__lanes_add(y, one), half);
    e = cohsm__lanes_add(cohsm__lanes_mul(e, half), cohsm__lanes_all(0.01f));
    return cohsm__mask_and(
        cohsm__lanes_at_least(cohsm__lanes_add(y, e), cohsm__lanes_all((float)t->row_begin + 0.5f)),
        cohsm__lanes_at_least(cohsm__lanes_all((float)t->row_end - 0.5f), cohsm__lanes_sub(y, e)));
}

/* Appends to a list the numbers, from first on, of the lanes of a mask, if they come before end. Returns the
   new count. */
static inline COHSM__IN_KERNEL uint32_t cohsm__append8(uint32_t *list, uint32_t count, cohsm__lane_mask mask,
                                                       uint32_t first, uint32_t end)
{
    const cohsm__lane_ints number =
        cohsm__ints_add(cohsm__ints_load(cohsm__numbers), cohsm__ints_all((int32_t)first));
    mask = cohsm__mask_and(mask, cohsm__ints_greater(cohsm__ints_all((int32_t)end), number));
    cohsm__ints_append((int32_t *)(void *)(list + count), mask, number);
    return count + cohsm__mask_count(mask);
}

/* Finds those of the clusters begin .. end - 1, no more than a stretch, that may be in sight of an
   orthographic view: by the boxes of eight clusters first. */
COHSM__KERNEL static void cohsm__find_clusters(const cohsm__target *t, cohsm__v3 up, const cohsm__soup *soup,
                                               uint32_t begin, uint32_t end, cohsm__sight *sight)
{
    const float *wide = cohsm__wide_bounds(soup);
    uint32_t eight[COHSM__STRETCH / 8 + 8], eights = cohsm__groups_of_8(end), count = 0, i;

    for (i = begin / 8; i < eights; i += 8)
        count = cohsm__append8(eight, count, cohsm__sees8(t, up, wide + 6 * (size_t)i), i, eights);
    for (i = 0, sight->count = 0; i < count; i++)
        sight->count =
            cohsm__append8(sight->cluster, sight->count,
                           cohsm__sees8(t, up, soup->bounds + 48 * (size_t)eight[i]), 8 * eight[i], end);
}

#endif
