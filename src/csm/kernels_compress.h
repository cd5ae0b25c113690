/* ---- kernels of compress: as many pixels as there are lanes ---- */

/* Returns x / 65535, rounded down, for x in 0..2^24. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__divide_65535(cohsm__lane_ints x)
{
    const cohsm__lane_ints more = cohsm__ints_add(x, cohsm__ints_all(1));
    return cohsm__ints_shift_right(cohsm__ints_add(more, cohsm__ints_shift_right(x, 16)), 16);
}

/* Returns what cohsm__grid_above and cohsm__grid_below return. */
static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__grid_above_lanes(cohsm__lane_ints depth, int32_t top)
{
    const cohsm__lane_ints scaled = cohsm__ints_mul(depth, cohsm__ints_all(top));
    return cohsm__divide_65535(cohsm__ints_add(scaled, cohsm__ints_all(65534)));
}

static inline COHSM__IN_KERNEL cohsm__lane_ints cohsm__grid_below_lanes(cohsm__lane_ints depth, int32_t top)
{
    const cohsm__lane_ints scaled = cohsm__ints_mul(depth, cohsm__ints_all(top));
    return cohsm__divide_65535(cohsm__ints_add(scaled, cohsm__ints_all(top - 1)));
}

/* The interval that cohsm__interval gives for each pixel, what it returns, and which pixels have a first
   layer without a second. */
typedef struct cohsm__intervals { cohsm__lane_ints lo, hi; cohsm__lane_mask empty, open; } cohsm__intervals;

static inline COHSM__IN_KERNEL cohsm__intervals cohsm__intervals_of(const cohsm__narrowing *n,
                                                                    const uint16_t *z)
{
    const cohsm__lane_ints all = cohsm__ints_all(COHSM__INFINITE), one = cohsm__ints_all(1);
    const cohsm__lane_ints both = cohsm__ints_load((const int32_t *)(const void *)z);
    const cohsm__lane_ints z1 = cohsm__ints_and(both, all);
    const cohsm__lane_ints z2 = cohsm__ints_and(cohsm__ints_shift_right(both, 16), all);
    const cohsm__lane_mask hit = cohsm__ints_greater(all, z1), no_second = cohsm__ints_equal(z2, all);
    /* Farther than 65536 is as far. */
    const cohsm__lanes behind = cohsm__lanes_min(
        cohsm__lanes_add(cohsm__lanes_mul(cohsm__lanes_all(n->slope), cohsm__lanes_of_ints(z1)),
                         cohsm__lanes_all(n->gap)), cohsm__lanes_all(65536.0f));
    const cohsm__lane_ints open = cohsm__ints_add(cohsm__ints_add(z1, one), cohsm__lanes_truncate(behind));
    const cohsm__lane_ints upper = cohsm__ints_select(no_second, open, z2);
    const cohsm__lane_mask room = cohsm__ints_greater(upper, z1);
    cohsm__intervals i;

    i.hi = cohsm__ints_min(cohsm__ints_sub(upper, one), cohsm__ints_all(COHSM__OPEN));
    i.hi = cohsm__ints_select(hit, cohsm__ints_select(room, i.hi, z1), all);
    i.lo = cohsm__ints_select(hit, z1, cohsm__ints_all(n->miss));
    i.empty = cohsm__mask_and(hit, cohsm__ints_greater(one, cohsm__ints_sub(upper, z1)));
    i.open = cohsm__mask_and(hit, no_second);
    return i;
}

/* Adds a view of two layers to the open segments of pixels, as cohsm__compress_pixel does, but for those that
   end, and for the last few pixels that are not as many as there are lanes. These it writes into `left`,
   which has room for 16 more, and returns how many they are. */
COHSM__KERNEL static uint32_t cohsm__narrow(cohsm__narrowing *n, const uint16_t *z, int32_t *span,
                                            uint32_t pixels, int32_t *left)
{
    const cohsm__lane_ints low_half = cohsm__ints_all(65535);
    uint32_t p, count = 0;

    for (p = 0; p + COHSM__LANE_COUNT <= pixels; p += COHSM__LANE_COUNT) {
        const cohsm__intervals i = cohsm__intervals_of(n, z + 2 * (size_t)p);
        const cohsm__lane_ints before = cohsm__ints_load(span + p);
        const cohsm__lane_ints lo = cohsm__ints_max(cohsm__ints_and(before, low_half),
                                                    cohsm__grid_above_lanes(i.lo, n->top));
        const cohsm__lane_ints hi = cohsm__ints_min(cohsm__ints_shift_right(before, 16),
                                                    cohsm__grid_below_lanes(i.hi, n->top));
        const cohsm__lane_mask ends = cohsm__ints_greater(lo, hi);
        const cohsm__lane_ints after = cohsm__ints_or(lo, cohsm__ints_mul(hi, cohsm__ints_all(65536)));
        const uint32_t go_on = ~cohsm__mask_bits(ends);
        cohsm__ints_store(span + p, cohsm__ints_select(ends, before, after));
        n->empty += cohsm__bit_count(cohsm__mask_bits(i.empty) & go_on);
        n->open += cohsm__bit_count(cohsm__mask_bits(i.open) & go_on);
        cohsm__ints_append(left + count, ends,
                           cohsm__ints_add(cohsm__ints_load(cohsm__numbers), cohsm__ints_all((int32_t)p)));
        count += cohsm__mask_count(ends);
    }
    for (; p < pixels; p++) left[count++] = (int32_t)p;
    return count;
}
