/* ---- kernels: where rays meet sixteen triangles ---- */

#define sfield__find_crossings SFIELD__NAME_IN_SET(sfield__find_crossings, SFIELD__SET)

/* See sfield__find_crossings16. Triangles are cones from the eye, as where views are drawn; one that lies on
   one face of the cube about the eye meets rays through that face alone. */
SFIELD__KERNEL static void sfield__find_crossings(const sfield__build *b, const float *eye,
                                                  sfield__inside_ray *ray)
{
    const sfield__lanes none = sfield__lanes_all(0);
    float way[16];
    size_t at;
    for (at = 0; at < b->triangles; at += 16) {
        const sfield__trio t = sfield__load_trio(b->corner + at, b->corner_room, eye);
        const sfield__lanes number = sfield__sides_of(t.a).number;
        const uint32_t one = sfield__on_one_face(&t, number);
        uint32_t on[6], front, seen;
        uint32_t i, bits;
        sfield__lanes3 n = sfield__lanes3_cross(t.a, t.b), o = sfield__lanes3_cross(t.b, t.c), all;
        sfield__lanes3 m = sfield__lanes3_cross(t.c, t.a);
        const sfield__lanes det = sfield__lanes3_dot(n, t.c);
        const sfield__lane_mask back = sfield__lanes_greater(none, det);
        const sfield__lanes turn = sfield__lanes_select(back, sfield__lanes_all(-1), sfield__lanes_all(1));
        front = sfield__mask_bits(sfield__lanes_greater(det, none));
        seen = front | sfield__mask_bits(back);
        if (!seen) continue;
        for (i = 0; i < 6; i++)
            on[i] = seen & (~one | ~sfield__mask_bits(
                                       sfield__lanes_differ(number, sfield__lanes_all((float)i))));
        n = sfield__lanes3_scale(n, turn);
        o = sfield__lanes3_scale(o, turn);
        m = sfield__lanes3_scale(m, turn);
        all = sfield__lanes3_add(sfield__lanes3_add(n, o), m);
        for (i = 0; i < SFIELD__INSIDE_RAYS; i++) {
            const sfield__lanes3 d = sfield__lanes3_all(ray[i].d[0], ray[i].d[1], ray[i].d[2]);
            sfield__lane_mask hit;
            if (!on[ray[i].face]) continue;
            hit = sfield__mask_and(sfield__lanes_greater(sfield__lanes3_dot(n, d), none),
                                   sfield__lanes_greater(sfield__lanes3_dot(o, d), none));
            hit = sfield__mask_and(hit, sfield__lanes_greater(sfield__lanes3_dot(m, d), none));
            bits = on[ray[i].face] & sfield__mask_bits(hit);
            if (!bits) continue;
            sfield__lanes_store(way, sfield__lanes_div(sfield__lanes_abs(det), sfield__lanes3_dot(all, d)));
            for (; bits; bits &= bits - 1) {
                const uint32_t l = sfield__first_bit(bits);
                sfield__add_crossing(&ray[i], way[l], (int)(front >> l & 1));
            }
        }
    }
}
