/* ---- kernels: which share of a VPL's map clusters of triangles fill ---- */

#define ism__lanes_facing ISM__NAME_IN_SET(ism__lanes_facing, ISM__SET)
#define ism__cluster_effect ISM__NAME_IN_SET(ism__cluster_effect, ISM__SET)
#define ism__box_zoom ISM__NAME_IN_SET(ism__box_zoom, ISM__SET)
#define ism__cluster_zoom ISM__NAME_IN_SET(ism__cluster_zoom, ISM__SET)
#define ism__weigh_clusters ISM__NAME_IN_SET(ism__weigh_clusters, ISM__SET)

/* Returns the mean square of n . l over the normals n of clusters, or 0 where rounding made it negative. */
static inline ISM__IN_KERNEL ism__lanes ism__lanes_facing(const ism__clusters *c, size_t i, ism__lanes3 l)
{
    const ism__lanes xx = ism__lanes_mul(ism__lanes_mul(ism__lanes_load(c->n[0] + i), l.x), l.x);
    const ism__lanes yy = ism__lanes_mul(ism__lanes_mul(ism__lanes_load(c->n[1] + i), l.y), l.y);
    const ism__lanes zz = ism__lanes_mul(ism__lanes_mul(ism__lanes_load(c->n[2] + i), l.z), l.z);
    const ism__lanes yz = ism__lanes_mul(ism__lanes_mul(ism__lanes_load(c->n[3] + i), l.y), l.z);
    const ism__lanes zx = ism__lanes_mul(ism__lanes_mul(ism__lanes_load(c->n[4] + i), l.z), l.x);
    const ism__lanes xy = ism__lanes_mul(ism__lanes_mul(ism__lanes_load(c->n[5] + i), l.x), l.y);
    const ism__lanes mixed = ism__lanes_mul(ism__lanes_all(2.0f), ism__lanes_add(ism__lanes_add(yz, zx), xy));
    const ism__lanes sum = ism__lanes_add(ism__lanes_add(ism__lanes_add(xx, yy), zz), mixed);
    return ism__lanes_max(sum, ism__lanes_all(0.0f));
}

/* Returns about which share of the VPL's map clusters fill: their cosine-weighted solid angles; in a map of
   directions their projected areas. */
static inline ISM__IN_KERNEL ism__lanes ism__cluster_effect(const ism__clusters *c, size_t i,
                                                            const ism_vpl *v)
{
    const ism__lanes zero = ism__lanes_all(0.0f), one = ism__lanes_all(1.0f);
    const ism__lanes area = ism__lanes_load(c->area + i), radius2 = ism__lanes_load(c->radius2 + i);
    const ism__lanes wide = ism__lanes_mul(ism__lanes_all(0.16f), area);
    const ism__lanes3 n = ism__lanes3_all(v->normal[0], v->normal[1], v->normal[2]);
    ism__lanes3 l = n;
    ism__lanes away2, d2;
    ism__lanes along, facing2, effect;
    if (v->directional) {
        facing2 = ism__lanes_facing(c, i, l);
        effect = ism__lanes_mul(area, ism__lanes_sqrt(facing2));
        return ism__lanes_keep(ism__lanes_greater(area, zero), effect);
    }
    l = ism__lanes3_sub(ism__lanes3_load(c->at[0] + i, c->at[1] + i, c->at[2] + i),
                        ism__lanes3_all(v->position[0], v->position[1], v->position[2]));
    away2 = ism__lanes3_dot(l, l);
    d2 = ism__lanes_add(ism__lanes_add(away2, radius2), wide);
    along = ism__lanes_add(ism__lanes3_dot(l, n), ism__lanes_sqrt(radius2));
    facing2 = ism__lanes_add(ism__lanes_facing(c, i, l),        /* close clusters are seen from all sides */
                             ism__lanes_add(radius2, wide));
    effect = ism__lanes_mul(ism__lanes_mul(area, ism__lanes_sqrt(facing2)),
                            ism__lanes_div(along, ism__lanes_mul(d2, d2)));
    effect = ism__lanes_keep(ism__lanes_greater(along, zero), effect);
    effect = ism__lanes_select(ism__lanes_greater(away2, zero), effect, one);
    return ism__lanes_keep(ism__lanes_greater(area, zero), effect);
}

/* Returns how many times longer the range within r of u is in the tile than in the square. */
static inline ISM__IN_KERNEL ism__lanes ism__box_zoom(const ism__axis *w, ism__lanes u, ism__lanes r)
{
    const ism__lanes one = ism__lanes_all(1.0f), zero = ism__lanes_all(0.0f);
    const ism__lanes low = ism__lanes_select(ism__lanes_greater(u, r), ism__lanes_sub(u, r), zero);
    const ism__lanes high = ism__lanes_min(ism__lanes_add(u, r), one);
    const ism__lanes from = w->on ? ism__lanes_to_tile(w, low) : low;
    const ism__lanes to = w->on ? ism__lanes_to_tile(w, high) : high;
    return ism__lanes_div(ism__lanes_sub(to, from), ism__lanes_sub(high, low));
}

/* Returns about how many times more texels clusters have than in a map that shows the square evenly: the mean
   over a box of their size. Clusters behind the horizon, which may have a part before the horizon, count as
   on the horizon. */
static inline ISM__IN_KERNEL ism__lanes ism__cluster_zoom(const ism_maps *m, const ism__clusters *c,
                                                          size_t i, const ism_vpl *v,
                                                          const ism__orientation *f, const ism__window *w)
{
    const float *origin = v->directional ? m->center : v->position;
    const ism__lanes zero = ism__lanes_all(0.0f), half = ism__lanes_all(0.5f), one = ism__lanes_all(1.0f);
    const ism__lanes3 from = ism__lanes3_all(origin[0], origin[1], origin[2]);
    const ism__lanes3 z = ism__lanes3_all(f->z.x, f->z.y, f->z.z);
    ism__lanes3 at = ism__lanes3_sub(ism__lanes3_load(c->at[0] + i, c->at[1] + i, c->at[2] + i), from);
    ism__lanes d = ism__lanes_all(m->radius), r = ism__lanes_sqrt(ism__lanes_load(c->radius2 + i)), zoom;
    ism__lane_mask seen;
    ism__places uv;
    if (!v->directional) {
        const ism__lanes below = ism__lanes3_dot(z, at);
        ism__lanes least;
        d = ism__lanes_sqrt(ism__lanes3_dot(at, at));
        least = ism__lanes_mul(ism__lanes_all(0.05f), d);
        at = ism__lanes3_select(ism__lanes_greater(least, below),
                                ism__lanes3_madd(at, z, ism__lanes_sub(least, below)), at);
    }
    at.x = ism__lanes_sub(ism__lanes_add(from.x, at.x), from.x);
    at.y = ism__lanes_sub(ism__lanes_add(from.y, at.y), from.y);
    at.z = ism__lanes_sub(ism__lanes_add(from.z, at.z), from.z);
    at = ism__lanes3_turn(f, at);
    if (v->directional) {
        uv.u = ism__lanes_add(ism__lanes_div(ism__lanes_mul(half, at.x), d), half);
        uv.v = ism__lanes_add(ism__lanes_div(ism__lanes_mul(half, at.y), d), half);
        seen = ism__mask_and(ism__lanes_at_least(uv.u, zero), ism__lanes_at_least(uv.v, zero));
        seen = ism__mask_and(seen, ism__lanes_greater(one, uv.u));
        seen = ism__mask_and(seen, ism__lanes_greater(one, uv.v));
    } else {
        const ism__lanes length = ism__lanes_sqrt(ism__lanes3_dot(at, at));
        at = ism__lanes3_scale(at, ism__lanes_div(one, length));
        seen = ism__mask_and(ism__lanes_greater(length, zero),
                             ism__lanes_at_least(ism__lanes_all(ISM__MAX_FLOAT), length));
        seen = ism__mask_and(seen, ism__lanes_greater(at.z, zero));
        uv = ism__project(ism__projection_of(m, v), v->exponent, at);
    }
    r = ism__lanes_div(ism__lanes_mul(half, r), d);     /* a radian is about half the square */
    r = ism__lanes_max(r, ism__lanes_all(0.01f));
    zoom = ism__lanes_mul(ism__box_zoom(&w->u, uv.u, r), ism__box_zoom(&w->v, uv.v, r));
    return ism__lanes_select(seen, zoom, one);
}

/* See ism__cluster_kernel. */
ISM__KERNEL static void ism__weigh_clusters(const ism__spread_work *w, const ism_vpl *v, float *effect)
{
    const ism_maps *m = w->m;
    const ism__window *window = (const ism__window *)m->windows.data + (v - m->vpls);
    const ism__orientation f = ism__vpl_axes(m, v);
    const int windows = window->u.on || window->v.on;
    size_t c;
    for (c = 0; c < w->cluster_count; c += ISM__LANE_COUNT) {
        const ism__clusters *from = &w->clusters[c / ISM__BUNDLE];
        const size_t i = c % ISM__BUNDLE, count = w->cluster_count - c;
        ism__lanes some = ism__cluster_effect(from, i, v);
        float last[ISM__LANE_COUNT];
        if (windows) some = ism__lanes_select(ism__lanes_greater(some, ism__lanes_all(0.0f)),
                                              ism__lanes_mul(some, ism__cluster_zoom(m, from, i, v, &f,
                                                                                     window)), some);
        some = ism__lanes_keep(ism__lanes_at_least(ism__lanes_all(ISM__MAX_FLOAT), some), some);
        if (count >= ISM__LANE_COUNT) {
            ism__lanes_store(effect + c, some);
            continue;
        }
        ism__lanes_store(last, some);
        memcpy(effect + c, last, count * sizeof *last);
    }
}
