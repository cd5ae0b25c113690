/* ---- kernels: where sixteen points lie, and which occluders they see ---- */

#if SFIELD__WIDTH <= 8          /* with AVX-512 those of AVX2 serve */
/* Returns 4/pi atan u for |u| <= 1: equal angles between the nodes of the position grid. The fit is our own,
   within 6e-6, and exact at the ends. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__warp_angle(sfield__lanes u)
{
    const sfield__lanes v = sfield__lanes_mul(u, u), one = sfield__lanes_all(1);
    sfield__lanes s = sfield__lanes_mul(v, sfield__lanes_all(0.0127531015f));
    s = sfield__lanes_mul(v, sfield__lanes_add(sfield__lanes_all(-0.0487783181f), s));
    s = sfield__lanes_mul(v, sfield__lanes_add(sfield__lanes_all(0.0946681494f), s));
    s = sfield__lanes_mul(v, sfield__lanes_add(sfield__lanes_all(-0.150161507f), s));
    s = sfield__lanes_add(sfield__lanes_all(0.273219633f), s);
    return sfield__lanes_add(u, sfield__lanes_mul(sfield__lanes_mul(u, sfield__lanes_sub(one, v)), s));
}

/* Writes how far points lie between the nodes of one axis of a face, and returns the nodes before them. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__node_before(sfield__lanes u, uint32_t side,
                                                                  float *fraction)
{
    const sfield__lanes half = sfield__lanes_all(0.5f * (float)(side - 1)), one = sfield__lanes_all(1);
    const sfield__lanes s = sfield__lanes_mul(sfield__lanes_add(sfield__warp_angle(u), one), half);
    const sfield__lanes most = sfield__lanes_min(s, sfield__lanes_all((float)side - 1.5f));
    const sfield__lanes node = sfield__lanes_of_ints(sfield__lanes_truncate(most));
    sfield__lanes_store(fraction, sfield__lanes_sub(s, node));
    return node;
}

/* Returns what sfield__measure_of says of squared distances of at least 1e-12. */
static inline SFIELD__IN_KERNEL sfield__lanes sfield__lanes_measure(const sfield_field *f, sfield__lanes d2)
{
    const sfield__lanes one = sfield__lanes_all(1), r = sfield__lanes_div(one, d2);
    const sfield__lanes u = sfield__lanes_min(r, one);
    sfield__lanes w;
    if (f->h.spacing == SFIELD_SPACING_UNIFORM) return sfield__lanes_negate(sfield__lanes_sqrt(d2));
    if (f->h.kind == SFIELD__KIND_SOURCE) return r;
    w = sfield__lanes_div(u, sfield__lanes_add(one, sfield__lanes_sqrt(sfield__lanes_sub(one, u))));
    return sfield__lanes_select(sfield__lanes_greater(one, d2), r, w);
}

/* Computes the weights of both shells; shell: of the inner one. */
static inline SFIELD__IN_KERNEL void sfield__weigh_shells(const sfield_field *f, sfield__lanes d2,
                                                          sfield__lane_ints shell, sfield__place *out)
{
    const sfield__lanes one = sfield__lanes_all(1), q = sfield__lanes_max(d2, sfield__lanes_all(1e-12f));
    const sfield__lanes m0 = sfield__lanes_gather(f->measure, shell);
    const sfield__lanes m1 = sfield__lanes_gather(f->measure + 1, shell);
    const sfield__lanes tail = sfield__lanes_div(sfield__lanes_all(f->radius2[f->h.shells - 1]), q);
    sfield__lanes w = sfield__lanes_sub(sfield__lanes_measure(f, q), m1);
    w = sfield__lanes_div(w, sfield__lanes_sub(m0, m1));
    w = sfield__lanes_min(sfield__lanes_max(w, sfield__lanes_all(0)), one);
    sfield__lanes_store(out->w0, w);
    sfield__lanes_store(out->w1, sfield__lanes_mul(sfield__lanes_sub(one, w), sfield__lanes_min(tail, one)));
}

/* See sfield__locate16. Numbers of samples are floats until they are stored: 64 shells of 6 x 64^2 samples
   are less than 2^24. */
SFIELD__KERNEL static void sfield__locate(const sfield_field *f, const float *p, sfield__place *out)
{
    const sfield__lanes zero = sfield__lanes_all(0), one = sfield__lanes_all(1);
    const sfield__lanes x = sfield__lanes_load(p), y = sfield__lanes_load(p + 16);
    const sfield__lanes z = sfield__lanes_load(p + 32);
    const sfield__lanes ax = sfield__lanes_abs(x), ay = sfield__lanes_abs(y), az = sfield__lanes_abs(z);
    const sfield__lanes m = sfield__lanes_max(sfield__lanes_max(ax, ay), az);
    const sfield__lane_mask is_x = sfield__lanes_at_least(ax, m), is_y = sfield__lanes_at_least(ay, m);
    const sfield__lanes major = sfield__lanes_select(is_x, x, sfield__lanes_select(is_y, y, z));
    const sfield__lane_mask up = sfield__lanes_greater(major, zero);
    const sfield__lanes turn = sfield__lanes_select(up, one, sfield__lanes_all(-1));
    const sfield__lanes inverse = sfield__lanes_div(one, sfield__lanes_max(m, sfield__lanes_all(1e-20f)));
    const sfield__lanes side = sfield__lanes_all((float)f->h.position_side);
    const sfield__lanes z_turned = sfield__lanes_mul(z, turn);
    sfield__lanes d2 = sfield__lanes_add(sfield__lanes_mul(x, x), sfield__lanes_mul(y, y));
    sfield__lanes s = sfield__lanes_select(is_y, x, sfield__lanes_mul(x, turn)), t = sfield__lanes_negate(y);
    sfield__lanes shell = sfield__lanes_all(-1), face;
    uint32_t k;
    s = sfield__lanes_select(is_x, sfield__lanes_negate(z_turned), s);
    t = sfield__lanes_select(is_x, t, sfield__lanes_select(is_y, z_turned, t));
    face = sfield__lanes_select(is_y, sfield__lanes_all(2), sfield__lanes_all(4));
    face = sfield__lanes_select(is_x, zero, face);
    face = sfield__lanes_add(face, sfield__lanes_select(up, zero, one));
    d2 = sfield__lanes_add(d2, sfield__lanes_mul(z, z));
    /* If all points lie beyond the last shell but one, no shell has to be compared. */
    k = sfield__mask_bits(sfield__lanes_at_least(d2, sfield__lanes_all(f->radius2[f->h.shells - 2])));
    if (k == 0xffff) shell = sfield__lanes_all((float)f->h.shells);
    for (k = k == 0xffff ? f->h.shells : 0; k < f->h.shells; k++) {
        const sfield__lane_mask outside = sfield__lanes_at_least(d2, sfield__lanes_all(f->radius2[k]));
        if (!sfield__mask_any(outside)) break;
        shell = sfield__lanes_add(shell, sfield__lanes_keep(outside, one));
    }
    shell = sfield__lanes_min(sfield__lanes_max(shell, zero), sfield__lanes_all((float)(f->h.shells - 2)));
    s = sfield__node_before(sfield__lanes_mul(s, inverse), f->h.position_side, out->fx);
    t = sfield__node_before(sfield__lanes_mul(t, inverse), f->h.position_side, out->fy);
    face = sfield__lanes_add(sfield__lanes_mul(shell, sfield__lanes_all(6)), face);
    face = sfield__lanes_add(sfield__lanes_mul(face, side), t);
    face = sfield__lanes_add(sfield__lanes_mul(face, side), s);
    sfield__ints_store(out->base, sfield__lanes_truncate(face));
    sfield__ints_store(out->shell, sfield__lanes_truncate(shell));
    sfield__weigh_shells(f, d2, sfield__lanes_truncate(shell), out);
}

/* Returns the bits of lanes whose base is the wanted one. */
SFIELD__KERNEL static uint32_t sfield__same_eight(const int32_t *base, int32_t wanted)
{
    return sfield__mask_bits(sfield__ints_equal(sfield__ints_load(base), sfield__ints_all(wanted)));
}

/* Copies planes, with zeros where a mask has no bit. */
SFIELD__KERNEL static void sfield__select(const float *in, uint32_t n, uint32_t mask, float *out)
{
    const sfield__lane_mask lanes = sfield__mask_of_bits(mask);
    const float *end = in + n;
    for (; in < end; in += 16, out += 16)
        sfield__lanes_store(out, sfield__lanes_keep(lanes, sfield__lanes_load(in)));
}

/* Computes where points are in a field of an entity: planes, about its center c, in r. m: 3 x 3; f: 1 / r. */
SFIELD__KERNEL static void sfield__to_local(const float *m, const float *c, float f, const float *p,
                                            float *local)
{
    const sfield__lanes by = sfield__lanes_all(f);
    sfield__lanes x = sfield__lanes_sub(sfield__lanes_load(p), sfield__lanes_all(c[0]));
    sfield__lanes y = sfield__lanes_sub(sfield__lanes_load(p + 16), sfield__lanes_all(c[1]));
    sfield__lanes z = sfield__lanes_sub(sfield__lanes_load(p + 32), sfield__lanes_all(c[2]));
    uint32_t k;
    x = sfield__lanes_mul(x, by);
    y = sfield__lanes_mul(y, by);
    z = sfield__lanes_mul(z, by);
    for (k = 0; k < 3; k++, m += 3) {
        sfield__lanes a = sfield__lanes_mul(sfield__lanes_all(m[0]), x);
        a = sfield__lanes_add(a, sfield__lanes_mul(sfield__lanes_all(m[1]), y));
        a = sfield__lanes_add(a, sfield__lanes_mul(sfield__lanes_all(m[2]), z));
        sfield__lanes_store(local + 16 * k, a);
    }
}

/* Returns the bits of lanes with a < b. */
SFIELD__KERNEL static uint32_t sfield__nearer(const float *a, const float *b)
{
    return sfield__mask_bits(sfield__lanes_greater(sfield__lanes_load(b), sfield__lanes_load(a)));
}

/* Computes the squared distances of the lanes to c. The bits returned: nearer than reach, and, from 16 on, c
   higher above the horizon than low. */
SFIELD__KERNEL static uint32_t sfield__look_at(const float *p, const float *n, const float *c, float reach2,
                                               float low, float *d2)
{
    const sfield__lanes x = sfield__lanes_sub(sfield__lanes_all(c[0]), sfield__lanes_load(p));
    const sfield__lanes y = sfield__lanes_sub(sfield__lanes_all(c[1]), sfield__lanes_load(p + 16));
    const sfield__lanes z = sfield__lanes_sub(sfield__lanes_all(c[2]), sfield__lanes_load(p + 32));
    sfield__lanes d = sfield__lanes_add(sfield__lanes_mul(x, x), sfield__lanes_mul(y, y));
    sfield__lanes h = sfield__lanes_mul(x, sfield__lanes_load(n));
    h = sfield__lanes_add(h, sfield__lanes_mul(y, sfield__lanes_load(n + 16)));
    h = sfield__lanes_add(h, sfield__lanes_mul(z, sfield__lanes_load(n + 32)));
    d = sfield__lanes_add(d, sfield__lanes_mul(z, z));
    sfield__lanes_store(d2, d);
    return sfield__mask_bits(sfield__lanes_greater(sfield__lanes_all(reach2), d)) |
           sfield__mask_bits(sfield__lanes_greater(h, sfield__lanes_all(low))) << 16;
}

/* Computes what is left of an occluder: 1 up to 3/4 of its reach, 0 for lanes that do not count. */
SFIELD__KERNEL static void sfield__fade(const float *d2, float inverse_reach, uint32_t lanes, float *factor)
{
    const sfield__lanes one = sfield__lanes_all(1);
    sfield__lanes d = sfield__lanes_sqrt(sfield__lanes_load(d2));
    d = sfield__lanes_mul(d, sfield__lanes_all(inverse_reach));
    d = sfield__lanes_min(sfield__lanes_mul(sfield__lanes_all(4), sfield__lanes_sub(one, d)), one);
    sfield__lanes_store(factor, sfield__lanes_keep(sfield__mask_of_bits(lanes), d));
}
#endif

/* Computes n planes that a cache has kept, in 16 bits, with a scale for each lane. */
SFIELD__KERNEL static void sfield__recall(const int16_t *value, const float *scale, uint32_t n, float *t)
{
    const sfield__lanes by = sfield__lanes_load(scale);
    const int16_t *end = value + 16 * (size_t)n;
    for (; value < end; value += 16, t += 16)
        sfield__lanes_store(t, sfield__lanes_mul(sfield__lanes_of_shorts(value), by));
}
