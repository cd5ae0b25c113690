/* ---- kernel of interpolation ---- */

#if RSM__LANE_COUNT == 8
/* Does what rsm__suit_kernel says, eight pixels at a time: count is a multiple of 8. */
RSM__KERNEL static void rsm__suit_tile(rsm__tile *t, size_t count, const float s[6], const float limits[3],
                                       int32_t bit)
{
    const rsm__lanes3 position = rsm__lanes3_all(s[0], s[1], s[2]),
        normal = rsm__lanes3_all(s[3], s[4], s[5]);
    size_t i;
    for (i = 0; i < count; i += 8) {
        const rsm__lanes3 d = rsm__lanes3_sub(position, rsm__lanes3_load(t->px + i, t->py + i, t->pz + i));
        const rsm__lanes3 n = rsm__lanes3_load(t->nx + i, t->ny + i, t->nz + i);
        const rsm__lanes d2 = rsm__lanes3_dot(d, d), plane = rsm__lanes3_dot(d, n),
            other = rsm__lanes3_dot(d, normal);
        const rsm__lanes most = rsm__lanes_mul(rsm__lanes_all(limits[1]), d2);
        rsm__lane_mask fits = rsm__lanes_at_least(rsm__lanes3_dot(normal, n), rsm__lanes_all(limits[0]));
        fits = rsm__mask_and(fits, rsm__lanes_at_least(most, rsm__lanes_mul(plane, plane)));
        fits = rsm__mask_and(fits, rsm__lanes_at_least(most, rsm__lanes_mul(other, other)));
        fits = rsm__mask_and(fits, rsm__lanes_at_least(rsm__lanes_all(limits[2]), d2));
        rsm__ints_store(t->good + i,
                        rsm__ints_or(rsm__ints_load(t->good + i), rsm__ints_keep(fits, rsm__ints_all(bit))));
    }
}
#endif
