/* ---- kernels of raster: as many triangles as there are lanes ---- */

/* These kernels give what cohsm__fill_triangle gives, to the last bit. Nearly all boxes of a fine mesh hold
   no sample or a few: triangles with such boxes go through their samples together, a triangle a lane;
   triangles with larger boxes take cohsm__fill_triangle. */

typedef struct cohsm__triangles {
    cohsm__lane_ints x0, x1, x2;
    cohsm__lane_ints y0, y1, y2;
    cohsm__lanes z0, z1, z2;
} cohsm__triangles;

/* The samples of the triangles' boxes: columns lx..hx, rows ly..hy. */
typedef struct cohsm__spans { cohsm__lane_ints lx, hx, ly, hy; } cohsm__spans;

/* Writes the first and the last sample between the least and the greatest of three coordinates that lies
   within begin..end - 1. */
static inline COHSM__IN_KERNEL void cohsm__span(cohsm__lane_ints a, cohsm__lane_ints b, cohsm__lane_ints c,
                                                int begin, int end, cohsm__lane_ints *low,
                                                cohsm__lane_ints *high)
{
    const cohsm__lane_ints l = cohsm__ints_min(cohsm__ints_min(a, b), c);
    const cohsm__lane_ints h = cohsm__ints_max(cohsm__ints_max(a, b), c);
    *low = cohsm__ints_shift_right(cohsm__ints_add(l, cohsm__ints_all(127)), 8);
    *high = cohsm__ints_shift_right(cohsm__ints_sub(h, cohsm__ints_all(128)), 8);
    *low = cohsm__ints_max(*low, cohsm__ints_all(begin));
    *high = cohsm__ints_min(*high, cohsm__ints_all(end - 1));
}

static inline COHSM__IN_KERNEL cohsm__spans cohsm__spans_of(const cohsm__target *t, const cohsm__triangles *p)
{
    cohsm__spans s;
    cohsm__span(p->x0, p->x1, p->x2, 0, t->size, &s.lx, &s.hx);
    cohsm__span(p->y0, p->y1, p->y2, t->row_begin, t->row_end, &s.ly, &s.hy);
    return s;
}

/* Twice the areas that a sample makes with the three sides of a triangle; w0 belongs to the side opposite
   corner 0, and so on. */
typedef struct cohsm__sides { cohsm__lane_ints w0, w1, w2; } cohsm__sides;

/* Returns twice the area that the side from a to b makes with the origin. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__side_from(cohsm__lane_ints ax, cohsm__lane_ints ay,
                                                                 cohsm__lane_ints bx, cohsm__lane_ints by)
{
    return cohsm__ints_sub(cohsm__ints_mul(ax, by), cohsm__ints_mul(bx, ay));
}

/* Returns what cohsm__edge_loses says as the number that the area must exceed: -1 if the side from a to b
   takes the samples exactly on it, else 0. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__side_loses(cohsm__lane_ints ax, cohsm__lane_ints ay,
                                                                  cohsm__lane_ints bx, cohsm__lane_ints by)
{
    const cohsm__lane_mask along = cohsm__mask_and(cohsm__ints_equal(by, ay), cohsm__ints_greater(bx, ax));
    return cohsm__ints_keep(cohsm__mask_or(cohsm__ints_greater(by, ay), along), cohsm__ints_all(-1));
}

static inline COHSM__IN_KERNEL cohsm__sides cohsm__sides_step(cohsm__sides s, const cohsm__sides *step)
{
    s.w0 = cohsm__ints_add(s.w0, step->w0);
    s.w1 = cohsm__ints_add(s.w1, step->w1);
    s.w2 = cohsm__ints_add(s.w2, step->w2);
    return s;
}

/* Returns the areas at sample (x, y). Coordinates relative to the sample stay below 2^11, so that 32 bits are
   enough. */
static inline COHSM__IN_KERNEL cohsm__sides cohsm__side_areas(const cohsm__triangles *p, cohsm__lane_ints x,
                                                              cohsm__lane_ints y)
{
    const cohsm__lane_ints pixel = cohsm__ints_all(COHSM__SUBPIXEL);
    const cohsm__lane_ints middle = cohsm__ints_all(COHSM__SUBPIXEL / 2);
    const cohsm__lane_ints sx = cohsm__ints_add(cohsm__ints_mul(x, pixel), middle);
    const cohsm__lane_ints sy = cohsm__ints_add(cohsm__ints_mul(y, pixel), middle);
    const cohsm__lane_ints x0 = cohsm__ints_sub(p->x0, sx), y0 = cohsm__ints_sub(p->y0, sy);
    const cohsm__lane_ints x1 = cohsm__ints_sub(p->x1, sx), y1 = cohsm__ints_sub(p->y1, sy);
    const cohsm__lane_ints x2 = cohsm__ints_sub(p->x2, sx), y2 = cohsm__ints_sub(p->y2, sy);
    cohsm__sides s;
    s.w0 = cohsm__side_from(x1, y1, x2, y2);
    s.w1 = cohsm__side_from(x2, y2, x0, y0);
    s.w2 = cohsm__side_from(x0, y0, x1, y1);
    return s;
}

/* Swaps the last two corners of triangles that are seen from behind. */
static inline COHSM__IN_KERNEL void cohsm__to_front(cohsm__triangles *p, cohsm__lane_mask behind)
{
    const cohsm__lane_ints x1 = p->x1, y1 = p->y1;
    const cohsm__lanes z1 = p->z1;
    p->x1 = cohsm__ints_select(behind, p->x2, x1);
    p->y1 = cohsm__ints_select(behind, p->y2, y1);
    p->z1 = cohsm__lanes_select(behind, p->z2, z1);
    p->x2 = cohsm__ints_select(behind, x1, p->x2);
    p->y2 = cohsm__ints_select(behind, y1, p->y2);
    p->z2 = cohsm__lanes_select(behind, z1, p->z2);
}

/* Notes the depths of one sample a lane, that at (x, y) with the areas w, for the lanes of a mask. */
static inline COHSM__IN_KERNEL void cohsm__note_samples(const cohsm__target *t, const cohsm__triangles *p,
                                                        const cohsm__sides *w, cohsm__lanes scale,
                                                        cohsm__lane_ints x, cohsm__lane_ints y,
                                                        cohsm__lane_mask drawn, cohsm__hits *hits)
{
    const cohsm__lanes top = cohsm__lanes_all((float)COHSM__HIT_MAX);
    const cohsm__lane_ints pixel = cohsm__ints_add(cohsm__ints_mul(y, cohsm__ints_all(t->size)), x);
    cohsm__lanes z = cohsm__lanes_mul(cohsm__lanes_of_ints(w->w0), p->z0);

    z = cohsm__lanes_add(z, cohsm__lanes_mul(cohsm__lanes_of_ints(w->w1), p->z1));
    z = cohsm__lanes_add(z, cohsm__lanes_mul(cohsm__lanes_of_ints(w->w2), p->z2));
    z = cohsm__lanes_mul(cohsm__lanes_mul(z, scale), top);
    z = cohsm__lanes_min(cohsm__lanes_max(z, cohsm__lanes_all(0.0f)), top);
    cohsm__ints_append(hits->pixel + hits->count, drawn, pixel);
    cohsm__ints_append(hits->depth + hits->count, drawn, cohsm__lanes_truncate(z));
    hits->count += cohsm__mask_count(drawn);
    if (hits->count > COHSM__MANY) cohsm__enter_hits(t, hits);
}

/* Draws triangles by going through all samples of their boxes together. */
static inline COHSM__IN_KERNEL void cohsm__draw_boxes(const cohsm__target *t, cohsm__triangles *p,
                                                      const cohsm__spans *span, cohsm__lane_mask use,
                                                      cohsm__hits *hits)
{
    const cohsm__lane_ints zero = cohsm__ints_all(0), one = cohsm__ints_all(1);
    const cohsm__lane_ints pixel = cohsm__ints_all(COHSM__SUBPIXEL);
    cohsm__lane_ints area = cohsm__side_from(cohsm__ints_sub(p->x1, p->x0), cohsm__ints_sub(p->y1, p->y0),
                                             cohsm__ints_sub(p->x2, p->x0), cohsm__ints_sub(p->y2, p->y0));
    const cohsm__lane_ints end_x = cohsm__ints_add(span->hx, one), end_y = cohsm__ints_add(span->hy, one);
    cohsm__lane_ints loses0, loses1, loses2;
    cohsm__lane_ints x, y;
    cohsm__sides right, up, row, w;
    cohsm__lane_mask in_row, wanted;
    cohsm__lanes scale;

    cohsm__to_front(p, cohsm__ints_greater(zero, area));
    area = cohsm__ints_max(area, cohsm__ints_sub(zero, area));
    use = cohsm__mask_and(use, cohsm__ints_greater(area, zero));
    scale = cohsm__lanes_div(cohsm__lanes_all(1.0f), cohsm__lanes_of_ints(area));
    loses0 = cohsm__side_loses(p->x1, p->y1, p->x2, p->y2);
    loses1 = cohsm__side_loses(p->x2, p->y2, p->x0, p->y0);
    loses2 = cohsm__side_loses(p->x0, p->y0, p->x1, p->y1);
    right.w0 = cohsm__ints_mul(cohsm__ints_sub(p->y1, p->y2), pixel);
    right.w1 = cohsm__ints_mul(cohsm__ints_sub(p->y2, p->y0), pixel);
    right.w2 = cohsm__ints_mul(cohsm__ints_sub(p->y0, p->y1), pixel);
    up.w0 = cohsm__ints_mul(cohsm__ints_sub(p->x2, p->x1), pixel);
    up.w1 = cohsm__ints_mul(cohsm__ints_sub(p->x0, p->x2), pixel);
    up.w2 = cohsm__ints_mul(cohsm__ints_sub(p->x1, p->x0), pixel);
    row = cohsm__side_areas(p, span->lx, span->ly);
    for (y = span->ly;; y = cohsm__ints_add(y, one), row = cohsm__sides_step(row, &up)) {
        in_row = cohsm__mask_and(use, cohsm__ints_greater(end_y, y));
        if (!cohsm__mask_any(in_row)) break;
        for (x = span->lx, w = row;; x = cohsm__ints_add(x, one), w = cohsm__sides_step(w, &right)) {
            wanted = cohsm__mask_and(in_row, cohsm__ints_greater(end_x, x));
            if (!cohsm__mask_any(wanted)) break;
            wanted = cohsm__mask_and(wanted, cohsm__ints_greater(w.w0, loses0));
            wanted = cohsm__mask_and(wanted, cohsm__ints_greater(w.w1, loses1));
            wanted = cohsm__mask_and(wanted, cohsm__ints_greater(w.w2, loses2));
            if (COHSM__WIDTH == 1 && !cohsm__mask_any(wanted)) continue;
            cohsm__note_samples(t, p, &w, scale, x, y, wanted, hits);
        }
    }
}

/* Draws one triangle of the queue by cohsm__fill_triangle. */
static inline COHSM__IN_KERNEL void cohsm__draw_alone(const cohsm__target *t, const cohsm__camera *cam,
                                                      const cohsm__queue *q, uint32_t at)
{
    cohsm__corner c[3];
    int k;
    for (k = 0; k < 3; k++) {
        c[k].x = q->x[k][at];
        c[k].y = q->y[k][at];
        c[k].z = q->z[k][at];
    }
    cohsm__fill_triangle(t, cam, NULL, c, c + 1, c + 2);
}

/* Draws the triangles of the queue from number at on, as many as there are lanes or are left. */
static inline COHSM__IN_KERNEL void cohsm__draw_some(const cohsm__target *t, const cohsm__camera *cam,
                                                     const cohsm__queue *q, uint32_t at, cohsm__hits *hits)
{
    const cohsm__lane_ints few = cohsm__ints_all(5), left = cohsm__ints_all((int32_t)(q->count - at));
    cohsm__lane_mask some, slight;
    cohsm__triangles p;
    cohsm__spans span;
    uint32_t large;

    p.x0 = cohsm__ints_load(q->x[0] + at);
    p.x1 = cohsm__ints_load(q->x[1] + at);
    p.x2 = cohsm__ints_load(q->x[2] + at);
    p.y0 = cohsm__ints_load(q->y[0] + at);
    p.y1 = cohsm__ints_load(q->y[1] + at);
    p.y2 = cohsm__ints_load(q->y[2] + at);
    p.z0 = cohsm__lanes_load(q->z[0] + at);
    p.z1 = cohsm__lanes_load(q->z[1] + at);
    p.z2 = cohsm__lanes_load(q->z[2] + at);
    span = cohsm__spans_of(t, &p);
    some = cohsm__ints_greater(left, cohsm__ints_load(cohsm__numbers));
    slight = cohsm__mask_and(some, cohsm__ints_greater(few, cohsm__ints_sub(span.hx, span.lx)));
    slight = cohsm__mask_and(slight, cohsm__ints_greater(few, cohsm__ints_sub(span.hy, span.ly)));
    large = cohsm__mask_bits(some) & ~cohsm__mask_bits(slight);
    for (; large; large &= large - 1u) cohsm__draw_alone(t, cam, q, at + cohsm__first_bit(large));
    if (cohsm__mask_any(slight)) cohsm__draw_boxes(t, &p, &span, slight, hits);
}

/* Draws triangles of the queue, as long as there is one for each lane, and moves those that are left to the
   front. If all is not 0, draws those too. There is one function for both, since compilers need a second for
   each copy of cohsm__draw_some. */
COHSM__KERNEL static void cohsm__draw_queue(const cohsm__target *t, const cohsm__camera *cam, cohsm__queue *q,
                                            int all)
{
    const uint32_t most = all ? COHSM__LANE_COUNT - 1u : 0u;
    cohsm__hits hits;
    uint32_t at;
    int k;

    hits.count = 0;
    for (at = 0; at + COHSM__LANE_COUNT <= q->count + most; at += COHSM__LANE_COUNT)
        cohsm__draw_some(t, cam, q, at, &hits);
    cohsm__enter_hits(t, &hits);
    if (at >= q->count) {
        q->count = 0;
        return;
    }
    for (k = 0; k < 3; k++) {
        memcpy(q->x[k], q->x[k] + at, COHSM__LANE_COUNT * sizeof q->x[k][0]);
        memcpy(q->y[k], q->y[k] + at, COHSM__LANE_COUNT * sizeof q->y[k][0]);
        memcpy(q->z[k], q->z[k] + at, COHSM__LANE_COUNT * sizeof q->z[k][0]);
    }
    q->count -= at;
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

/* Puts those triangles of a mask into the queue that hold a sample row, by their corners and by their x in p,
   which hold a sample column. */
static inline COHSM__IN_KERNEL void cohsm__queue_triangles(const cohsm__target *t,
                                                           const cohsm__image_axes *axes,
                                                           const cohsm__lanes3 *corner, cohsm__triangles *p,
                                                           cohsm__lane_mask use, cohsm__queue *q)
{
    const cohsm__lane_ints one = cohsm__ints_all(1);
    cohsm__lane_ints low, high;
    p->y0 = cohsm__fixed(corner[0], axes->up, axes->offset);
    p->y1 = cohsm__fixed(corner[1], axes->up, axes->offset);
    p->y2 = cohsm__fixed(corner[2], axes->up, axes->offset);
    p->z0 = cohsm__depths(corner[0], axes->half_back);
    p->z1 = cohsm__depths(corner[1], axes->half_back);
    p->z2 = cohsm__depths(corner[2], axes->half_back);
    cohsm__span(p->y0, p->y1, p->y2, t->row_begin, t->row_end, &low, &high);
    use = cohsm__mask_and(use, cohsm__ints_greater(cohsm__ints_add(high, one), low));
    if (COHSM__WIDTH == 1 && !cohsm__mask_any(use)) return;
    cohsm__queue_add(q, p, use);
}

/* Finds x of the corners. Returns which triangles hold a sample column. */
static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__find_x(const cohsm__target *t,
                                                              const cohsm__image_axes *axes,
                                                              const cohsm__lanes3 *corner,
                                                              cohsm__triangles *p)
{
    cohsm__lane_ints low, high;
    p->x0 = cohsm__fixed(corner[0], axes->right, axes->offset);
    p->x1 = cohsm__fixed(corner[1], axes->right, axes->offset);
    p->x2 = cohsm__fixed(corner[2], axes->right, axes->offset);
    cohsm__span(p->x0, p->x1, p->x2, 0, t->size, &low, &high);
    return cohsm__ints_greater(cohsm__ints_add(high, cohsm__ints_all(1)), low);
}

/* Puts the triangles of the clusters in sight of an orthographic view into the queue. */
COHSM__KERNEL static void cohsm__enqueue(const cohsm__target *t, const cohsm__camera *cam,
                                         const cohsm__soup *soup, const cohsm__sight *sight, cohsm__queue *q)
{
    enum { PARTS = COHSM__CLUSTER / COHSM__LANE_COUNT };
    const cohsm__image_axes axes = cohsm__image_axes_of(t, &cam->axes);
    uint32_t i;

    for (i = 0; i < PARTS * sight->count; i++) {
        const float *v = cohsm__cluster(soup, sight->cluster[i / PARTS]) + COHSM__LANE_COUNT * (i % PARTS);
        cohsm__lanes3 corner[3];
        cohsm__triangles p;
        cohsm__lane_mask use;
        corner[0] = cohsm__corner_load(v);
        corner[1] = cohsm__corner_load(v + 3 * COHSM__CLUSTER);
        corner[2] = cohsm__corner_load(v + 6 * COHSM__CLUSTER);
        use = cohsm__find_x(t, &axes, corner, &p);
        cohsm__queue_triangles(t, &axes, corner, &p, use, q);
        if (q->count > COHSM__MANY) cohsm__draw_queue(t, cam, q, 0);
    }
}

/* Appends the triangles of a mask to those of the slab, with the x that p holds. */
static inline COHSM__IN_KERNEL void cohsm__slab_add(cohsm__slab *slab, const cohsm__triangles *p,
                                                     const cohsm__lanes3 *corner, cohsm__lane_mask m)
{
    const uint32_t at = slab->count;
    int k;
    cohsm__ints_append(slab->x[0] + at, m, p->x0);
    cohsm__ints_append(slab->x[1] + at, m, p->x1);
    cohsm__ints_append(slab->x[2] + at, m, p->x2);
    for (k = 0; k < 3; k++) {
        cohsm__lanes_append(slab->corner[3 * k] + at, m, corner[k].x);
        cohsm__lanes_append(slab->corner[3 * k + 1] + at, m, corner[k].y);
        cohsm__lanes_append(slab->corner[3 * k + 2] + at, m, corner[k].z);
    }
    slab->count = at + cohsm__mask_count(m);
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
        cohsm__triangles p;
        cohsm__lane_mask use;
        cohsm__prefetch_part(soup, sight->cluster[ahead], i % PARTS);
        corner[0] = cohsm__corner_load(v);
        corner[1] = cohsm__corner_load(v + 3 * COHSM__CLUSTER);
        corner[2] = cohsm__corner_load(v + 6 * COHSM__CLUSTER);
        use = cohsm__find_x(t, &axes, corner, &p);
        cohsm__slab_add(slab, &p, corner, use);
    }
}

/* Puts the triangles of a slab into the queue of one of its views. */
COHSM__KERNEL static void cohsm__enqueue_slab(const cohsm__target *t, const cohsm__camera *cam,
                                               const cohsm__slab *slab, cohsm__queue *q)
{
    const cohsm__image_axes axes = cohsm__image_axes_of(t, &cam->axes);
    uint32_t at, k;

    for (at = 0; at < slab->count; at += COHSM__LANE_COUNT) {
        const cohsm__lane_ints left = cohsm__ints_all((int32_t)(slab->count - at));
        cohsm__lanes3 corner[3];
        cohsm__triangles p;
        p.x0 = cohsm__ints_load(slab->x[0] + at);
        p.x1 = cohsm__ints_load(slab->x[1] + at);
        p.x2 = cohsm__ints_load(slab->x[2] + at);
        for (k = 0; k < 3; k++)
            corner[k] = cohsm__lanes3_load(slab->corner[3 * k] + at, slab->corner[3 * k + 1] + at,
                                           slab->corner[3 * k + 2] + at);
        cohsm__queue_triangles(t, &axes, corner, &p,
                               cohsm__ints_greater(left, cohsm__ints_load(cohsm__numbers)), q);
        if (q->count > COHSM__MANY) cohsm__draw_queue(t, cam, q, 0);
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
