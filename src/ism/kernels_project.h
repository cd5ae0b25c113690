/* ---- kernels: places of directions in a tile, by ism_map_coordinates and ism__to_tile ---- */

static inline ISM__IN_KERNEL ism__lanes3 ism__lanes3_cross(ism__lanes3 a, ism__lanes3 b)
{
    ism__lanes3 c;
    c.x = ism__lanes_sub(ism__lanes_mul(a.y, b.z), ism__lanes_mul(a.z, b.y));
    c.y = ism__lanes_sub(ism__lanes_mul(a.z, b.x), ism__lanes_mul(a.x, b.z));
    c.z = ism__lanes_sub(ism__lanes_mul(a.x, b.y), ism__lanes_mul(a.y, b.x));
    return c;
}

/* Returns a + b s. */
static inline ISM__IN_KERNEL ism__lanes3 ism__lanes3_madd(ism__lanes3 a, ism__lanes3 b, ism__lanes s)
{
    a.x = ism__lanes_add(a.x, ism__lanes_mul(b.x, s));
    a.y = ism__lanes_add(a.y, ism__lanes_mul(b.y, s));
    a.z = ism__lanes_add(a.z, ism__lanes_mul(b.z, s));
    return a;
}

/* Returns vectors in the axes of an orientation. */
static inline ISM__IN_KERNEL ism__lanes3 ism__lanes3_turn(const ism__orientation *f, ism__lanes3 v)
{
    ism__lanes3 out;
    out.x = ism__lanes3_dot(ism__lanes3_all(f->x.x, f->x.y, f->x.z), v);
    out.y = ism__lanes3_dot(ism__lanes3_all(f->y.x, f->y.y, f->y.z), v);
    out.z = ism__lanes3_dot(ism__lanes3_all(f->z.x, f->z.y, f->z.z), v);
    return out;
}

/* Returns m ? a : b. */
static inline ISM__IN_KERNEL ism__lanes3 ism__lanes3_select(ism__lane_mask m, ism__lanes3 a, ism__lanes3 b)
{
    a.x = ism__lanes_select(m, a.x, b.x);
    a.y = ism__lanes_select(m, a.y, b.y);
    a.z = ism__lanes_select(m, a.z, b.z);
    return a;
}

/* Writes three arrays, from element l on. */
static inline ISM__IN_KERNEL void ism__lanes3_store(float (*to)[ISM__DISCS], size_t l, ism__lanes3 a)
{
    ism__lanes_store(to[0] + l, a.x);
    ism__lanes_store(to[1] + l, a.y);
    ism__lanes_store(to[2] + l, a.z);
}

/* Places in the square, or in the tile. */
typedef struct ism__places { ism__lanes u, v; } ism__places;

/* Does for lanes what ism__to_tile does, for an axis that is on. */
static inline ISM__IN_KERNEL ism__lanes ism__lanes_to_tile(const ism__axis *w, ism__lanes u)
{
    const ism__lanes lo = ism__lanes_all(w->lo), hi = ism__lanes_all(w->hi), zero = ism__lanes_all(0.0f);
    const ism__lanes below = ism__lanes_mul(u, ism__lanes_all(w->below));
    const ism__lanes inside = ism__lanes_add(
        ism__lanes_all(w->a), ism__lanes_mul(ism__lanes_sub(u, lo), ism__lanes_all(w->inside)));
    const ism__lanes above = ism__lanes_add(
        ism__lanes_all(w->b), ism__lanes_mul(ism__lanes_sub(u, hi), ism__lanes_all(w->above)));
    ism__lanes x = ism__lanes_select(ism__lanes_greater(hi, u), inside, above);
    x = ism__lanes_select(ism__lanes_greater(lo, u), below, x);
    return ism__lanes_min(ism__lanes_max(x, zero), ism__lanes_all(1.0f));
}

/* Does for lanes what ism__disc_to_square does. The angle from the nearer axis of the disc is within 45
   degrees, so the part of ism__atan2 for 0 <= |y| <= x is enough. */
static inline ISM__IN_KERNEL ism__places ism__square_of_disc(ism__lanes x, ism__lanes y)
{
    const ism__lanes zero = ism__lanes_all(0.0f), one = ism__lanes_all(1.0f);
    const ism__lanes radius = ism__lanes_sqrt(ism__lanes_add(ism__lanes_mul(x, x), ism__lanes_mul(y, y)));
    const ism__lane_mask wide = ism__lanes_greater(ism__lanes_abs(x), ism__lanes_abs(y));
    const ism__lanes major = ism__lanes_select(wide, x, y), minor = ism__lanes_select(wide, y, x);
    const ism__lane_mask back = ism__lanes_greater(zero, major);
    const ism__lanes length = ism__lanes_abs(major);
    const ism__lane_mask some = ism__lanes_greater(length, zero);
    const ism__lanes a = ism__lanes_div(ism__lanes_abs(minor), ism__lanes_select(some, length, one));
    const ism__lane_mask big = ism__lanes_greater(a, ism__lanes_all(0.414213562f));
    const ism__lanes t = ism__lanes_select(
        big, ism__lanes_div(ism__lanes_sub(a, one), ism__lanes_add(a, one)), a);
    const ism__lanes z = ism__lanes_mul(t, t);
    ism__lanes angle = ism__lanes_add(ism__lanes_all(-0.1387984996f),
                                      ism__lanes_mul(z, ism__lanes_all(0.08060308882f)));
    ism__places out;
    angle = ism__lanes_add(ism__lanes_all(0.1997792608f), ism__lanes_mul(z, angle));
    angle = ism__lanes_add(ism__lanes_all(-0.3333295525f), ism__lanes_mul(z, angle));
    angle = ism__lanes_add(t, ism__lanes_mul(ism__lanes_mul(t, z), angle));
    angle = ism__lanes_select(big, ism__lanes_add(angle, ism__lanes_all(0.785398163f)), angle);
    angle = ism__lanes_select(ism__lanes_greater(zero, minor), ism__lanes_negate(angle), angle);
    out.u = ism__lanes_select(back, ism__lanes_negate(radius), radius);
    out.v = ism__lanes_mul(ism__lanes_mul(out.u, ism__lanes_all(1.27323954f)), angle);
    out.v = ism__lanes_select(back, ism__lanes_negate(out.v), out.v);
    angle = out.u;
    out.u = ism__lanes_select(wide, angle, out.v);
    out.v = ism__lanes_select(wide, out.v, angle);
    return out;
}

/* Returns by how much ism_map_coordinates stretches x and y in a map of LOBE. This takes exponentials in
   doubles, which lanes do not have. */
static inline ISM__IN_KERNEL ism__lanes ism__stretch_to_lobe(ism__lanes3 d, float exponent)
{
    float z[ISM__LANE_COUNT], sine[ISM__LANE_COUNT];
    int l;
    ism__lanes_store(z, d.z);
    ism__lanes_store(sine, ism__lanes_sqrt(ism__lanes_add(ism__lanes_mul(d.x, d.x),
                                                          ism__lanes_mul(d.y, d.y))));
    for (l = 0; l < ISM__LANE_COUNT; l++) z[l] = ism__lobe_stretch(z[l], sine[l], exponent);
    return ism__lanes_load(z);
}

/* Does for lanes what ism_map_coordinates does, for directions before the horizon. */
static inline ISM__IN_KERNEL ism__places ism__project(ism_projection projection, float exponent,
                                                      ism__lanes3 d)
{
    const ism__lanes zero = ism__lanes_all(0.0f), half = ism__lanes_all(0.5f), one = ism__lanes_all(1.0f);
    ism__lanes s;
    ism__places out;
    if (projection == ISM_PROJECTION_PARABOLOID) {
        s = ism__lanes_add(one, d.z);
        out.u = ism__lanes_div(d.x, s);
        out.v = ism__lanes_div(d.y, s);
    } else if (projection == ISM_PROJECTION_OCTAHEDRAL) {
        s = ism__lanes_add(ism__lanes_add(ism__lanes_abs(d.x), ism__lanes_abs(d.y)), d.z);
        s = ism__lanes_div(one, s);
        out.u = ism__lanes_mul(ism__lanes_add(d.x, d.y), s);
        out.v = ism__lanes_mul(ism__lanes_sub(d.x, d.y), s);
    } else {
        if (projection == ISM_PROJECTION_LOBE && exponent != 1.0f) {
            s = ism__stretch_to_lobe(d, exponent);
            d.x = ism__lanes_mul(d.x, s);
            d.y = ism__lanes_mul(d.y, s);
        }
        out = ism__square_of_disc(d.x, d.y);
    }
    out.u = ism__lanes_add(ism__lanes_mul(half, out.u), half);
    out.v = ism__lanes_add(ism__lanes_mul(half, out.v), half);
    out.u = ism__lanes_min(ism__lanes_max(out.u, zero), one);
    out.v = ism__lanes_min(ism__lanes_max(out.v, zero), one);
    return out;
}
