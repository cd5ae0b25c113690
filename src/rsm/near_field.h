/* ---- near field: texels as the parallelograms that they are ---- */

/* Writes half the sides of the surface under a texel at p: the cross section of the texel's beam, carried
   along the beam onto the plane of n. The cosine counts as 0.05 at least, as in rsm_texel.area, so that both
   have the same area. */
static inline void rsm__texel_sides(const rsm_map *map, uint32_t face, rsm__v3 p, rsm__v3 n, rsm__v3 side[2])
{
    rsm__v3 a, d, along;
    float scale = map->extent / (float)map->side, facing, least;
    float bounded, length2;
    int k;
    rsm__face_frame(map, face, &side[0], &side[1], &a);
    d = a;
    if (!rsm__is_sun(map)) { /* d goes from the light to the plane at distance 1 */
        d = rsm__v3_sub(p, rsm__v3_load(map->desc.light.position));
        scale *= rsm__v3_dot(d, a);
        d = rsm__v3_scale(d, 1.0f / rsm__v3_dot(d, a));
    }
    facing = rsm__v3_dot(d, n);
    least = 0.05f * rsm__v3_length(d);
    bounded = rsm__copysign(fabsf(facing) > least ? fabsf(facing) : least, facing);
    along = rsm__v3_madd(d, n, -facing);
    length2 = rsm__v3_dot(along, along);
    for (k = 0; k < 2; k++) {
        float off = rsm__v3_dot(side[k], n), stretched = off / bounded;
        if (fabsf(facing) < least)
            stretched += rsm__v3_dot(side[k], along) / length2 * (1.0f - fabsf(facing) / least);
        side[k] = rsm__v3_scale(rsm__v3_madd(rsm__v3_madd(side[k], n, -off), along, -stretched), scale);
    }
}

/* Returns what the edge from a to b adds to Lambert's sum: angle(a, b) n . (b x a) / |b x a|. */
static inline float rsm__lambert_edge(rsm__v3 n, rsm__v3 a, rsm__v3 b)
{
    rsm__v3 c = rsm__v3_cross(rsm__v3_sub(b, a), a);
    float length = rsm__v3_length(c);
    return length > 0.0f ? rsm__atan2(length, rsm__v3_dot(a, b)) * (rsm__v3_dot(n, c) / length) : 0.0f;
}

/* Returns the integral of cos cos / d^2 over the parallelogram c +- u +- v, seen from the origin and clipped
   at the horizon of n. This is pi times the form factor, which is half of Lambert's sum over the edges (Baum,
   Rushmeier and Winget 1989). A parallelogram is convex, so that its outline goes below the horizon at one
   point (leave) and comes back at one other (come) at most; an edge from one to the other closes the outline
   again. */
static inline float rsm__parallelogram_form(rsm__v3 n, rsm__v3 c, rsm__v3 u, rsm__v3 v)
{
    rsm__v3 corner[4], leave = c, come = c;
    float height[4], sum = 0.0f;
    int k;
    for (k = 0; k < 4; k++) {
        corner[k] =
            rsm__v3_madd(rsm__v3_madd(c, u, k == 1 || k == 2 ? 1.0f : -1.0f), v, k > 1 ? 1.0f : -1.0f);
        height[k] = rsm__v3_dot(n, corner[k]);
    }
    for (k = 0; k < 4; k++) {
        rsm__v3 a = corner[k], b = corner[(k + 1) & 3];
        float ha = height[k], hb = height[(k + 1) & 3];
        if (!(ha > 0.0f) && !(hb > 0.0f)) continue;
        if (!(ha > 0.0f && hb > 0.0f)) {
            rsm__v3 at = rsm__v3_madd(a, rsm__v3_sub(b, a), ha / (ha - hb));
            if (ha > 0.0f) b = leave = at;
            else a = come = at;
        }
        sum += rsm__lambert_edge(n, a, b);
    }
    return 0.5f * fabsf(sum + rsm__lambert_edge(n, leave, come));
}

/* Returns the mean of cos cos / d^2 over the texel in lane i. As with points, a plane does not light itself.
   A receiver may lie nearer to the texel's plane than half its side and face it: so lies the back of a bent
   sheet that is lit from its other side, through which the parallelogram reaches, and depths cannot tell the
   two apart. For such a receiver the form goes over to that of a point by degrees, and reaches it at distance
   0 with 120 degrees or more between the normals. */
static inline float rsm__near_texel_form(const rsm_map *map, const rsm__block *k, size_t i, const float x[7])
{
    rsm__v3 p = rsm__v3_make(k->px[i], k->py[i], k->pz[i]), n = rsm__v3_make(k->nx[i], k->ny[i], k->nz[i]),
            side[2];
    rsm__v3 d = rsm__v3_sub(p, rsm__v3_load(x));
    float area, form, point;
    float height = -rsm__v3_dot(n, d), d2 = rsm__v3_dot(d, d);
    float facing = -2.0f * rsm__v3_dot(n, rsm__v3_load(x + 3)), above = rsm__v3_dot(rsm__v3_load(x + 3), d);
    if (!(height > (k->rounding[i] > x[6] ? k->rounding[i] : x[6]))) return 0.0f;
    rsm__texel_sides(map, (uint32_t)k->lx[i], p, n, side);
    area = 4.0f * rsm__v3_length(rsm__v3_cross(side[0], side[1]));
    form = area > 0.0f ? rsm__parallelogram_form(rsm__v3_load(x + 3), d, side[0], side[1]) / area : 0.0f;
    point = above > 0.0f ? (above / d2) * (height / d2) : 0.0f;
    if (form > point && facing > 0.0f && 4.0f * height * height < area)
        form += (facing < 1.0f ? facing : 1.0f) * (1.0f - 2.0f * height / sqrtf(area)) * (point - form);
    return form > 0.0f ? form : 0.0f; /* 0 for NaN, which positions make whose squares floats cannot hold */
}

/* Returns whether the light in lane i is near the receiver. */
static inline int rsm__is_near(const rsm__block *k, size_t i, const float x[7])
{
    float dx = k->px[i] - x[0], dy = k->py[i] - x[1], dz = k->pz[i] - x[2];
    return dx * dx + dy * dy + dz * dz < k->density[i];
}

/* Runs the kernel on a block of which some lights may be near. These are taken out of the block, which is not
   restored, and added one by one as parallelograms. */
static inline void rsm__kernel_near(const rsm__gather *g, const rsm_map *map, rsm__block *k, size_t count,
                                    const float x[7], rsm__sum *sum)
{
    float flux[RSM__BLOCK][3];
    size_t found[RSM__BLOCK], nearby = 0, i, j;
    for (i = 0; i < count; i++) {
        if (!rsm__is_near(k, i, x)) continue;
        flux[nearby][0] = k->r[i];
        flux[nearby][1] = k->g[i];
        flux[nearby][2] = k->b[i];
        k->r[i] = k->g[i] = k->b[i] = 0.0f;
        found[nearby++] = i;
    }
    g->kernel(k, count, x, sum);
    for (j = 0; j < nearby; j++) {
        float form = rsm__near_texel_form(map, k, found[j], x),
              f = form < k->cap[found[j]] ? form : k->cap[found[j]];
        int c;
        for (c = 0; c < 3; c++) {
            sum->rgb[c] += flux[j][c] * f;
            sum->full += flux[j][c] * form;
            sum->lost += flux[j][c] * (form - f);
        }
    }
}

/* Returns whether a light of the box may be near the receiver. */
static inline int rsm__is_within_reach(const rsm__reach *r, const float x[7])
{
    float d2 = 0.0f;
    int c;
    for (c = 0; c < 3; c++) {
        float below = r->low[c] - x[c], above = x[c] - r->high[c], d = below > above ? below : above;
        d2 += d > 0.0f ? d * d : 0.0f;
    }
    return d2 < r->most2;
}

static inline void rsm__reach_add(rsm__reach *r, float px, float py, float pz, float most2)
{
    const float p[3] = { px, py, pz };
    int c;
    for (c = 0; c < 3; c++) {
        r->low[c] = p[c] < r->low[c] ? p[c] : r->low[c];
        r->high[c] = p[c] > r->high[c] ? p[c] : r->high[c];
    }
    r->most2 = most2 > r->most2 ? most2 : r->most2;
}

/* Makes the boxes of a source's blocks and those of its runs, both set by set, once its lights are in place.
   */
static inline rsm_result rsm__find_reaches(const rsm__gather *g, rsm__source *s, const rsm__allocator *a)
{
    static const rsm__reach nothing = { { 3e38f, 3e38f, 3e38f }, { -3e38f, -3e38f, -3e38f }, 0.0f };
    size_t blocks = s->set_blocks * g->sets, i, l;
    s->set_runs = (s->set_blocks + RSM__RUN / RSM__BLOCK - 1) / (RSM__RUN / RSM__BLOCK);
    s->reaches = (rsm__reach *)rsm__alloc_array(a, blocks + s->set_runs * g->sets, sizeof *s->reaches);
    if (!s->reaches) return RSM_ERR_ALLOC;
    for (i = 0; i < blocks + s->set_runs * g->sets; i++) s->reaches[i] = nothing;
    for (i = 0; i < blocks; i++) {
        const rsm__block *k = s->blocks + i;
        size_t run = i / s->set_blocks * s->set_runs + i % s->set_blocks / (RSM__RUN / RSM__BLOCK);
        for (l = 0; l < RSM__BLOCK; l++) {
            if (!(k->density[l] > 0.0f)) continue;
            rsm__reach_add(&s->reaches[i], k->px[l], k->py[l], k->pz[l], k->density[l]);
            rsm__reach_add(&s->reaches[blocks + run], k->px[l], k->py[l], k->pz[l], k->density[l]);
        }
    }
    return RSM_OK;
}

/* Gathers from one run of a set's lights, of which some may be near. The run begins at lane `first`. */
static inline void rsm__gather_near(const rsm__gather *g, const rsm__source *s, uint32_t set, size_t first,
                                    size_t lanes, const float x[7], rsm__sum *sum)
{
    size_t i, at = set * s->set_blocks + first / RSM__BLOCK;
    for (i = 0; i < lanes; i += RSM__BLOCK, at++) {
        size_t count = lanes - i < RSM__BLOCK ? lanes - i : (size_t)RSM__BLOCK;
        if (rsm__is_within_reach(&s->reaches[at], x)) {
            rsm__block some = s->blocks[at];
            rsm__kernel_near(g, s->map, &some, count, x, sum);
        } else g->kernel(s->blocks + at, count, x, sum);
    }
}
