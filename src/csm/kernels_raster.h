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

/* Writes the first and the last sample between the least and the greatest of three coordinates, also beyond
   the image; the first is the last one's successor where there is none. */
static inline COHSM__IN_KERNEL void cohsm__span(cohsm__lane_ints a, cohsm__lane_ints b, cohsm__lane_ints c,
                                                cohsm__lane_ints *low, cohsm__lane_ints *high)
{
    const cohsm__lane_ints l = cohsm__ints_min(cohsm__ints_min(a, b), c);
    const cohsm__lane_ints h = cohsm__ints_max(cohsm__ints_max(a, b), c);
    *low = cohsm__ints_shift_right(cohsm__ints_add(l, cohsm__ints_all(127)), 8);
    *high = cohsm__ints_shift_right(cohsm__ints_sub(h, cohsm__ints_all(128)), 8);
}

/* Leaves of a span the samples begin..end - 1. */
static inline COHSM__IN_KERNEL void cohsm__span_clamp(cohsm__lane_ints *low, cohsm__lane_ints *high,
                                                      int begin, int end)
{
    *low = cohsm__ints_max(*low, cohsm__ints_all(begin));
    *high = cohsm__ints_min(*high, cohsm__ints_all(end - 1));
}

/* Says which spans hold one of the samples begin..end - 1. */
static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__span_meets(cohsm__lane_ints low, cohsm__lane_ints high,
                                                                  int begin, int end)
{
    cohsm__span_clamp(&low, &high, begin, end);
    return cohsm__ints_greater(cohsm__ints_add(high, cohsm__ints_all(1)), low);
}

static inline COHSM__IN_KERNEL cohsm__spans cohsm__spans_of(const cohsm__target *t, const cohsm__triangles *p)
{
    cohsm__spans s;
    cohsm__span(p->x0, p->x1, p->x2, &s.lx, &s.hx);
    cohsm__span(p->y0, p->y1, p->y2, &s.ly, &s.hy);
    cohsm__span_clamp(&s.lx, &s.hx, 0, t->size);
    cohsm__span_clamp(&s.ly, &s.hy, t->row_begin, t->row_end);
    return s;
}

/* Enters the hits, whose depths are computed as many at a time as there are lanes. */
static inline COHSM__IN_KERNEL void cohsm__enter_hits(const cohsm__target *t, cohsm__hits *hits)
{
    const cohsm__lanes top = cohsm__lanes_all((float)COHSM__HIT_MAX);
    uint32_t i;

    for (i = 0; i < hits->count; i += COHSM__LANE_COUNT) {
        const cohsm__lanes area = cohsm__lanes_of_ints(cohsm__ints_load(hits->area + i));
        cohsm__lanes z = cohsm__lanes_div(cohsm__lanes_all(1.0f), area);
        z = cohsm__lanes_mul(cohsm__lanes_mul(cohsm__lanes_load(hits->sum + i), z), top);
        z = cohsm__lanes_min(cohsm__lanes_max(z, cohsm__lanes_all(0.0f)), top);
        cohsm__ints_store(hits->depth + i, cohsm__lanes_truncate(z));
    }
    cohsm__insert_hits(t, hits);
}

/* Notes one sample a lane as hit, for the lanes of a mask. */
static inline COHSM__IN_KERNEL void cohsm__note_hits(const cohsm__target *t, cohsm__lane_mask hit,
                                                     cohsm__lane_ints pixel, cohsm__lanes sum,
                                                     cohsm__lane_ints area, cohsm__hits *hits)
{
    cohsm__ints_append(hits->pixel + hits->count, hit, pixel);
    cohsm__lanes_append(hits->sum + hits->count, hit, sum);
    cohsm__ints_append(hits->area + hits->count, hit, area);
    hits->count += cohsm__mask_count(hit);
    if (hits->count > COHSM__MANY) cohsm__enter_hits(t, hits);
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

/* Returns the areas at sample (x, y). Relative to the sample x stays below 2^11, and y below 2^18, as of tall
   triangles in a shard of few rows, so that 32 bits are enough. */
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

/* Draws triangles by going through all samples of their boxes together. */
static inline COHSM__IN_KERNEL void cohsm__draw_boxes(const cohsm__target *t, cohsm__triangles *p,
                                                      const cohsm__spans *span, cohsm__lane_mask use,
                                                      cohsm__hits *hits)
{
    const cohsm__lane_ints zero = cohsm__ints_all(0), one = cohsm__ints_all(1);
    const cohsm__lane_ints pixel = cohsm__ints_all(COHSM__SUBPIXEL), size = cohsm__ints_all(t->size);
    cohsm__lane_ints area = cohsm__side_from(cohsm__ints_sub(p->x1, p->x0), cohsm__ints_sub(p->y1, p->y0),
                                             cohsm__ints_sub(p->x2, p->x0), cohsm__ints_sub(p->y2, p->y0));
    const cohsm__lane_ints end_x = cohsm__ints_add(span->hx, one), end_y = cohsm__ints_add(span->hy, one);
    cohsm__lane_ints loses0, loses1, loses2;
    cohsm__lane_ints x, y;
    cohsm__sides right, up, row, w;
    cohsm__lane_mask in_row, wanted;
    cohsm__lanes sum;

    cohsm__to_front(p, cohsm__ints_greater(zero, area));
    area = cohsm__ints_max(area, cohsm__ints_sub(zero, area));
    use = cohsm__mask_and(use, cohsm__ints_greater(area, zero));
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
            sum = cohsm__lanes_mul(cohsm__lanes_of_ints(w.w0), p->z0);
            sum = cohsm__lanes_add(sum, cohsm__lanes_mul(cohsm__lanes_of_ints(w.w1), p->z1));
            sum = cohsm__lanes_add(sum, cohsm__lanes_mul(cohsm__lanes_of_ints(w.w2), p->z2));
            cohsm__note_hits(t, wanted, cohsm__ints_add(cohsm__ints_mul(y, size), x), sum, area, hits);
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

/* Draws specks from number at on, as many as there are lanes or are left. A sample is inside if it is on the
   same side of all three edges; one exactly on an edge counts as left of it, or as right of it, as
   cohsm__edge_loses has it for a triangle seen from in front. If the triangle is seen from behind, all
   areas are negative, and the sum of depths so, too; the order of its terms is that of
   cohsm__fill_triangle. */
static inline COHSM__IN_KERNEL void cohsm__draw_specks(const cohsm__target *t, const cohsm__specks *s,
                                                       uint32_t at, cohsm__hits *hits)
{
    const cohsm__lane_ints zero = cohsm__ints_all(0), minus = cohsm__ints_all(-1);
    const cohsm__lane_ints sign = cohsm__ints_all(0x8000), left = cohsm__ints_all((int32_t)(s->count - at));
    const cohsm__lane_ints p0 = cohsm__ints_load(s->corner[0] + at), k0 = cohsm__ints_xor(p0, sign);
    const cohsm__lane_ints p1 = cohsm__ints_load(s->corner[1] + at), k1 = cohsm__ints_xor(p1, sign);
    const cohsm__lane_ints p2 = cohsm__ints_load(s->corner[2] + at), k2 = cohsm__ints_xor(p2, sign);
    const cohsm__lane_ints w0 = cohsm__ints_cross_halves(p1, p2), w1 = cohsm__ints_cross_halves(p2, p0);
    const cohsm__lane_ints w2 = cohsm__ints_cross_halves(p0, p1);
    const cohsm__lane_ints area = cohsm__ints_add(cohsm__ints_add(w0, w1), w2);
    const cohsm__lane_ints side0 = cohsm__ints_add(w0, cohsm__ints_keep(cohsm__ints_greater(k1, k2), minus));
    const cohsm__lane_ints side1 = cohsm__ints_add(w1, cohsm__ints_keep(cohsm__ints_greater(k2, k0), minus));
    const cohsm__lane_ints side2 = cohsm__ints_add(w2, cohsm__ints_keep(cohsm__ints_greater(k0, k1), minus));
    const cohsm__lane_ints differ =
        cohsm__ints_or(cohsm__ints_xor(side0, side1), cohsm__ints_xor(side0, side2));
    const cohsm__lane_mask behind = cohsm__ints_greater(zero, area);
    const cohsm__lane_ints flat = cohsm__ints_xor(cohsm__ints_or(area, cohsm__ints_sub(zero, area)), minus);
    const cohsm__lane_mask inside = cohsm__ints_greater(cohsm__ints_or(differ, flat), minus);
    const cohsm__lane_mask some = cohsm__ints_greater(left, cohsm__ints_load(cohsm__numbers));
    const cohsm__lanes z0 = cohsm__lanes_mul(cohsm__lanes_of_ints(w0), cohsm__lanes_load(s->z[0] + at));
    const cohsm__lanes z1 = cohsm__lanes_mul(cohsm__lanes_of_ints(w1), cohsm__lanes_load(s->z[1] + at));
    const cohsm__lanes z2 = cohsm__lanes_mul(cohsm__lanes_of_ints(w2), cohsm__lanes_load(s->z[2] + at));
    const cohsm__lanes sum = cohsm__lanes_add(cohsm__lanes_add(z0, cohsm__lanes_select(behind, z2, z1)),
                                              cohsm__lanes_select(behind, z1, z2));
    cohsm__note_hits(t, cohsm__mask_and(some, inside), cohsm__ints_load(s->pixel + at), sum, area, hits);
}

/* Draws triangles of the queue, as long as there is one for each lane, and moves those that are left to the
   front. If all is not 0, draws those too. There is one function for both, since compilers need a second for
   each copy of cohsm__draw_some. */
COHSM__KERNEL static void cohsm__draw_queue(const cohsm__target *t, const cohsm__camera *cam, cohsm__queue *q,
                                            int all)
{
    const uint32_t most = all ? COHSM__LANE_COUNT - 1u : 0u;
    cohsm__specks *s = &q->specks;
    uint32_t at;
    int k;

    for (at = 0; at + COHSM__LANE_COUNT <= s->count + most; at += COHSM__LANE_COUNT)
        cohsm__draw_specks(t, s, at, &q->hits);
    for (k = 0; at && at < s->count && k < 3; k++) {
        memcpy(s->corner[k], s->corner[k] + at, COHSM__LANE_COUNT * sizeof s->corner[k][0]);
        memcpy(s->z[k], s->z[k] + at, COHSM__LANE_COUNT * sizeof s->z[k][0]);
    }
    if (at) memcpy(s->pixel, s->pixel + at, COHSM__LANE_COUNT * sizeof s->pixel[0]);
    s->count -= cohsm__min_u32(at, s->count);
    for (at = 0; at + COHSM__LANE_COUNT <= q->count + most; at += COHSM__LANE_COUNT)
        cohsm__draw_some(t, cam, q, at, &q->hits);
    for (k = 0; at && at < q->count && k < 3; k++) {
        memcpy(q->x[k], q->x[k] + at, COHSM__LANE_COUNT * sizeof q->x[k][0]);
        memcpy(q->y[k], q->y[k] + at, COHSM__LANE_COUNT * sizeof q->y[k][0]);
        memcpy(q->z[k], q->z[k] + at, COHSM__LANE_COUNT * sizeof q->z[k][0]);
    }
    q->count -= cohsm__min_u32(at, q->count);
    if (all) cohsm__enter_hits(t, &q->hits);
}
