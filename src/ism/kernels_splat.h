/* ---- kernels: points become discs in a tile (paper 3.3) ---- */

/* Writes the columns or rows of texels whose places in the square are within `reach` of u, as ism__to_tile
   says. */
static inline ISM__IN_KERNEL void ism__span_axis(const ism__axis *w, ism__lanes u, ism__lanes reach,
                                                 float size, int32_t *first, int32_t *last)
{
    const ism__lanes most = ism__lanes_all(size), zero = ism__lanes_all(0.0f);
    ism__lanes x0, x1;
    if (w->on) {
        const ism__lanes part = ism__lanes_div(reach, most);
        x0 = ism__lanes_mul(ism__lanes_to_tile(w, ism__lanes_sub(u, part)), most);
        x1 = ism__lanes_mul(ism__lanes_to_tile(w, ism__lanes_add(u, part)), most);
    } else {
        const ism__lanes middle = ism__lanes_mul(u, most);
        x0 = ism__lanes_sub(middle, reach);
        x1 = ism__lanes_add(middle, reach);
    }
    x1 = ism__lanes_select(ism__lanes_greater(most, x1), x1, ism__lanes_all(size - 1.0f));
    ism__ints_store(first, ism__lanes_truncate(ism__lanes_max(x0, zero)));
    ism__ints_store(last, ism__lanes_truncate(x1));
}

/* Prepares discs to be cut off at their triangles' edges. Points that stand for less than their triangle are
   cut, and may be large: so a wall has neither gaps nor discs that jut out over its end. A point that stands
   for neighbouring triangles too remains a disc. */
static inline ISM__IN_KERNEL void ism__cut_at_edges(const ism__tile *tile, ism__lane_mask cut, ism__lanes3 e1,
                                                    ism__lanes3 e2, ism__lanes3 n, ism__discs *s, size_t l)
{
    const ism__lanes zero = ism__lanes_all(0.0f);
    const ism__lanes3 none = ism__lanes3_all(0.0f, 0.0f, 0.0f);
    const ism__lanes inverse = ism__lanes_div(ism__lanes_all(1.0f), ism__lanes3_dot(n, n));
    const ism__lanes3 d1 = ism__lanes3_scale(ism__lanes3_cross(e2, n), inverse);
    const ism__lanes3 d2 = ism__lanes3_scale(ism__lanes3_cross(n, e1), inverse);
    ism__lanes_store(s->b1 + l, ism__lanes_select(cut, ism__lanes_load(s->b1 + l), zero));
    ism__lanes_store(s->b2 + l, ism__lanes_select(cut, ism__lanes_load(s->b2 + l), zero));
    ism__lanes3_store(s->d1, l, ism__lanes3_select(cut, ism__lanes3_turn(&tile->axes, d1), none));
    ism__lanes3_store(s->d2, l, ism__lanes3_select(cut, ism__lanes3_turn(&tile->axes, d2), none));
}

/* Places points in a sky's map: p from the mesh's centre, n unit. Returns which of them lie in the map. */
static inline ISM__IN_KERNEL ism__lane_mask ism__before_sky(const ism__tile *tile, ism__lanes3 p,
                                                            ism__lanes3 n, ism__discs *s, size_t l,
                                                            ism__places *uv)
{
    const ism__lanes zero = ism__lanes_all(0.0f), half = ism__lanes_all(0.5f), one = ism__lanes_all(1.0f);
    const ism__lanes r = ism__lanes_all(tile->m->radius);
    const ism__lane_mask steep = ism__lanes_greater(ism__lanes_abs(n.z), ism__lanes_all(0.05f));
    const ism__lanes slope = ism__lanes_keep(steep, ism__lanes_div(one, n.z));
    const ism__lanes depth = ism__lanes_add(p.z, r);    /* the tile's z is the way that light travels */
    ism__lanes3 g;
    ism__lane_mask inside;
    uv->u = ism__lanes_add(ism__lanes_div(ism__lanes_mul(half, p.x), r), half);
    uv->v = ism__lanes_add(ism__lanes_div(ism__lanes_mul(half, p.y), r), half);
    inside = ism__mask_and(ism__lanes_at_least(uv->u, zero), ism__lanes_at_least(uv->v, zero));
    inside = ism__mask_and(inside, ism__lanes_greater(one, uv->u));
    inside = ism__mask_and(inside, ism__lanes_greater(one, uv->v));
    g.x = ism__lanes_mul(ism__lanes_mul(ism__lanes_negate(n.x), slope), r);
    g.y = ism__lanes_mul(ism__lanes_mul(ism__lanes_negate(n.y), slope), r);
    g.z = ism__lanes_add(ism__lanes_mul(n.x, p.x), ism__lanes_mul(n.y, p.y));
    g.z = ism__lanes_add(depth, ism__lanes_mul(g.z, slope));
    p.z = depth;
    ism__lanes3_store(s->at, l, p);
    ism__lanes3_store(s->g, l, g);
    return inside;
}

/* A disc's squared radius, the disc's distance from the VPL, and whether the disc was made smaller. */
typedef struct ism__sizes { ism__lanes radius2, depth; ism__lane_mask capped; } ism__sizes;

/* Places points in a VPL's map: p from the VPL, n unit. Returns which of them the VPL sees before itself. */
static inline ISM__IN_KERNEL ism__lane_mask ism__before_vpl(const ism__tile *tile, ism__lanes3 p,
                                                            ism__lanes3 n, ism__lane_mask cut,
                                                            ism__discs *s, size_t l, ism__sizes *sizes,
                                                            ism__places *uv)
{
    const ism__lanes zero = ism__lanes_all(0.0f), one = ism__lanes_all(1.0f);
    const ism__lanes d2 = ism__lanes3_dot(p, p), along = ism__lanes3_dot(n, p), depth = ism__lanes_sqrt(d2);
    const ism__lanes least = ism__lanes_mul(ism__lanes_all(1e-3f), depth);
    const ism__lane_mask steep = ism__lanes_greater(ism__lanes_abs(along), least);
    ism__lane_mask seen = ism__mask_and(ism__lanes_greater(d2, ism__lanes_all(1e-30f)),
                                        ism__lanes_greater(p.z, least));
    ism__lanes3 g;
    ism__lanes most, away;
    if (tile->projection == ISM_PROJECTION_LOBE) {
        /* The surface that the VPL lies on is no occluder in a lobe's tilted map either. */
        const ism__orientation *f = &tile->axes;
        const float *normal = tile->vpl->normal;
        ism__lanes3 world = ism__lanes3_scale(ism__lanes3_all(f->x.x, f->x.y, f->x.z), p.x);
        world = ism__lanes3_madd(world, ism__lanes3_all(f->y.x, f->y.y, f->y.z), p.y);
        world = ism__lanes3_madd(world, ism__lanes3_all(f->z.x, f->z.y, f->z.z), p.z);
        away = ism__lanes3_dot(world, ism__lanes3_all(normal[0], normal[1], normal[2]));
        seen = ism__mask_and(seen, ism__lanes_greater(ism__lanes_abs(away), least));
    }
    /* A near disc that is seen from behind most likely juts out over the edge of something thin on the
       surface on which the VPL lies: the front of a skirting board must not hide the wall on which it hangs.
       */
    most = ism__lanes_select(ism__lanes_greater(along, zero), ism__lanes_all(ISM__WIDEST_BACK),
                             ism__lanes_all(ISM__WIDEST));
    most = ism__lanes_mul(ism__lanes_select(cut, ism__lanes_all(ISM__WIDEST), most), d2);
    sizes->capped = ism__lanes_greater(sizes->radius2, most);
    sizes->radius2 = ism__lanes_select(sizes->capped, most, sizes->radius2);
    *uv = ism__project(tile->projection, tile->vpl->exponent,
                       ism__lanes3_scale(p, ism__lanes_div(one, depth)));
    /* A disc that is seen from its edge has a plane that faces the VPL instead. */
    g = ism__lanes3_select(steep, ism__lanes3_scale(n, ism__lanes_div(one, along)),
                           ism__lanes3_scale(p, ism__lanes_div(one, d2)));
    /* A disc that stands for its triangle's neighbours too is about as far off their surface as it is wide,
       and would hide that surface from the VPL: it is drawn a radius farther away, as large as before for the
       VPL. */
    away = ism__lanes_add(one, ism__lanes_div(ism__lanes_sqrt(sizes->radius2), depth));
    away = ism__lanes_select(cut, one, away);
    ism__lanes3_store(s->at, l, ism__lanes3_scale(p, away));
    ism__lanes3_store(s->g, l, ism__lanes3_scale(g, ism__lanes_div(one, away)));
    sizes->radius2 = ism__lanes_mul(sizes->radius2, ism__lanes_mul(away, away));
    sizes->depth = ism__lanes_mul(depth, away);
    return seen;
}

/* Does what ism__splat's `place` does, for as many points as there are lanes, from point l on. */
static inline ISM__IN_KERNEL uint32_t ism__place_some(ism__tile *tile, ism__discs *s, size_t l)
{
    const int sky = tile->vpl->directional != 0;
    const float *from = sky ? tile->m->center : tile->vpl->position, scale = tile->m->desc.splat_scale;
    const ism__lanes one = ism__lanes_all(1.0f), zero = ism__lanes_all(0.0f);
    const ism__lanes weight = ism__lanes_load(s->weight + l);
    const ism__lane_mask cut = ism__lanes_greater(one, weight);
    ism__lanes3 p = ism__lanes3_load(s->corners[0][0] + l, s->corners[0][1] + l, s->corners[0][2] + l);
    const ism__lanes3 e1 = ism__lanes3_sub(ism__lanes3_load(s->corners[1][0] + l, s->corners[1][1] + l,
                                                            s->corners[1][2] + l), p);
    const ism__lanes3 e2 = ism__lanes3_sub(ism__lanes3_load(s->corners[2][0] + l, s->corners[2][1] + l,
                                                            s->corners[2][2] + l), p);
    const ism__lanes3 n = ism__lanes3_cross(e1, e2);
    const ism__lanes length = ism__lanes_sqrt(ism__lanes3_dot(n, n));
    ism__lanes area = ism__lanes_mul(ism__lanes_mul(ism__lanes_all(scale), weight), ism__lanes_all(0.5f));
    ism__lanes reach;
    ism__lane_mask seen = ism__mask_and(ism__lanes_greater(length, zero),
                                        ism__lanes_at_least(ism__lanes_all(ISM__MAX_FLOAT), length));
    ism__lanes3 normal = ism__lanes3_scale(n, ism__lanes_div(one, length));
    ism__sizes sizes;
    ism__places uv;
    p = ism__lanes3_madd(ism__lanes3_madd(p, e1, ism__lanes_load(s->b1 + l)), e2,
                         ism__lanes_load(s->b2 + l));
    p = ism__lanes3_turn(&tile->axes, ism__lanes3_sub(p, ism__lanes3_all(from[0], from[1], from[2])));
    normal = ism__lanes3_turn(&tile->axes, normal);
    area = ism__lanes_mul(area, length);
    area = ism__lanes_select(cut, ism__lanes_mul(area, ism__lanes_all(ISM__CUT_SCALE)), area);
    ism__cut_at_edges(tile, cut, e1, e2, n, s, l);
    sizes.radius2 = ism__lanes_mul(area, ism__lanes_all(1.0f / ISM__PI));
    sizes.depth = one;
    sizes.capped = ism__lanes_greater(zero, one);
    if (sky) seen = ism__mask_and(seen, ism__before_sky(tile, p, normal, s, l, &uv));
    else seen = ism__mask_and(seen, ism__before_vpl(tile, p, normal, cut, s, l, &sizes, &uv));
    ism__lanes_store(s->radius2 + l, sizes.radius2);
    seen = ism__mask_and(seen, ism__mask_of_bits(s->count - (uint32_t)l < ISM__LANE_COUNT
                                               ? (1u << (s->count - (uint32_t)l)) - 1u
                                               : UINT32_MAX));
    tile->splats += ism__mask_count(seen);
    reach = ism__lanes_mul(ism__lanes_sqrt(sizes.radius2), ism__lanes_all(tile->texels_per_unit));
    reach = ism__lanes_div(reach, sizes.depth);
    seen = ism__mask_and(seen, ism__lanes_greater(reach, zero));
    tile->wide += ism__mask_count(ism__mask_and(seen, sizes.capped));
    /* The map is continuous but across its diagonals near the border, where a disc is cut off. */
    reach = ism__lanes_keep(seen, ism__lanes_min(reach, ism__lanes_all((float)tile->size)));
    uv.u = ism__lanes_keep(seen, uv.u);
    uv.v = ism__lanes_keep(seen, uv.v);
    ism__span_axis(&tile->window->u, uv.u, reach, (float)tile->size, s->box[0] + l, s->box[1] + l);
    ism__span_axis(&tile->window->v, uv.v, reach, (float)tile->size, s->box[2] + l, s->box[3] + l);
    return ism__mask_bits(seen);
}

/* This is `place` of ism__splat. */
ISM__KERNEL static uint32_t ism__place_discs(ism__tile *tile, ism__discs *s)
{
    uint32_t bits = 0;
    size_t l;
    for (l = 0; l < s->count; l += ISM__LANE_COUNT) bits |= ism__place_some(tile, s, l) << l;
    return bits;
}

#if ISM__LANE_COUNT == 8
/* Returns a bit for each of eight texels, from texel i on, whose rays meet the disc, and nothing nearer; and
   writes the depths at which they meet its plane. */
static inline ISM__IN_KERNEL uint32_t ism__texels_hit(const ism__tile *tile, const ism__discs *s, size_t d,
                                                      size_t i, int sky, float depths[8])
{
    const ism__lanes zero = ism__lanes_all(0.0f), edge = ism__lanes_all(-ISM__EDGE);
    const ism__lanes3 w = ism__lanes3_load(tile->x + i, tile->y + i, tile->z + i);
    const ism__lanes plane = ism__lanes3_dot(ism__lanes3_all(s->g[0][d], s->g[1][d], s->g[2][d]), w);
    const ism__lanes depth = sky ? plane : ism__lanes_div(ism__lanes_all(1.0f), plane);
    const ism__lanes wide = sky ? ism__lanes_all(tile->m->radius) : depth;
    ism__lane_mask hit = ism__lanes_greater(plane, sky ? zero : ism__lanes_all(1e-20f));
    ism__lanes b1, b2;
    ism__lanes3 o;
    o.x = ism__lanes_sub(ism__lanes_mul(w.x, wide), ism__lanes_all(s->at[0][d]));
    o.y = ism__lanes_sub(ism__lanes_mul(w.y, wide), ism__lanes_all(s->at[1][d]));
    o.z = ism__lanes_sub(sky ? depth : ism__lanes_mul(w.z, depth), ism__lanes_all(s->at[2][d]));
    b1 = ism__lanes3_dot(o, ism__lanes3_all(s->d1[0][d], s->d1[1][d], s->d1[2][d]));
    b2 = ism__lanes3_dot(o, ism__lanes3_all(s->d2[0][d], s->d2[1][d], s->d2[2][d]));
    b1 = ism__lanes_add(ism__lanes_all(s->b1[d]), b1);
    b2 = ism__lanes_add(ism__lanes_all(s->b2[d]), b2);
    hit = ism__mask_and(hit, ism__lanes_greater(depth, zero));
    hit = ism__mask_and(hit, ism__lanes_greater(ism__lanes_load(tile->depth + i), depth));
    hit = ism__mask_and(hit, ism__lanes_at_least(ism__lanes_all(s->radius2[d]), ism__lanes3_dot(o, o)));
    hit = ism__mask_and(hit, ism__mask_and(ism__lanes_at_least(b1, edge), ism__lanes_at_least(b2, edge)));
    hit = ism__mask_and(hit, ism__lanes_at_least(ism__lanes_all(1.0f + ISM__EDGE), ism__lanes_add(b1, b2)));
    ism__lanes_store(depths, depth);
    return ism__mask_bits(hit);
}

/* Draws disc d into the texels of its box. No disc is widened to a whole texel: where many small ones share
   it, the chance that one holds the centre is the share of the texel that they cover, so that over many VPLs
   thin things throw thin shadows. Eight texels at a time; a row's last eight may begin before the box. */
static inline ISM__IN_KERNEL void ism__draw_disc(ism__tile *tile, const ism__discs *s, size_t d, int sky)
{
    const int32_t size = (int32_t)tile->size, last = s->box[1][d];
    int32_t x, y;
    for (y = s->box[2][d]; y <= s->box[3][d]; y++)
        for (x = s->box[0][d]; x <= last; x += 8) {
            const int32_t column = x < size - 8 ? x : size - 8, end = last - column;
            const size_t i = (size_t)(y * size + column);
            float depths[8];
            uint32_t bits = ism__texels_hit(tile, s, d, i, sky, depths);
            bits &= (255u << (x - column)) & (end < 8 ? (2u << end) - 1u : 255u);
            for (; bits; bits &= bits - 1u) {
                const size_t k = ism__first_bit(bits);
                ism__texel *to = &tile->texels[i + k];
                to->g[0] = s->g[0][d];
                to->g[1] = s->g[1][d];
                to->g[2] = s->g[2][d];
                to->triangle = s->triangle[d];
                tile->depth[i + k] = depths[k];
            }
        }
}

/* This is `draw` of ism__splat. */
ISM__KERNEL static void ism__draw_discs(ism__tile *tile, const ism__discs *s, uint32_t bits)
{
    if (tile->vpl->directional)
        for (; bits; bits &= bits - 1u) ism__draw_disc(tile, s, ism__first_bit(bits), 1);
    else
        for (; bits; bits &= bits - 1u) ism__draw_disc(tile, s, ism__first_bit(bits), 0);
}
#endif
