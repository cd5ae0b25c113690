/* ---- kernels of query: directions to latitude-longitude maps, in steps ---- */

#if COHSM__LANE_COUNT == 8

/* Takes square roots by lanes: sqrtf may set errno, so that compilers do not vectorise it. */
static inline COHSM__IN_KERNEL void cohsm__step_roots(float *x)
{
    int k;
    for (k = 0; k < COHSM__STEP; k += COHSM__LANE_COUNT)
        cohsm__lanes_store(x + k, cohsm__lanes_sqrt(cohsm__lanes_load(x + k)));
}

/* Finds where a step's lights lie in the domain, and the cells below, which may be one step outside. */
static inline COHSM__IN_KERNEL void cohsm__step_lights(cohsm__step *s, const cohsm__tile *t, size_t first)
{
    const float *x = t->light[0] + first, *y = t->light[1] + first, *z = t->light[2] + first;
    float top0 = (float)t->maps->head.side[0], top1 = (float)t->maps->head.side[1], u, v;
    float height[COHSM__STEP], root[COHSM__STEP];
    int32_t c0, c1;
    int k;

    for (k = 0; k < COHSM__STEP; k++) root[k] = x[k] * x[k] + y[k] * y[k] + z[k] * z[k];
    cohsm__step_roots(root);
    for (k = 0; k < COHSM__STEP; k++) {
        s->valid[k] = (root[k] > 0.0f) & (root[k] < 3.4e38f);
        height[k] = y[k] / root[k];
        root[k] = cohsm__acos_square(height[k]);
    }
    cohsm__step_roots(root);
    for (k = 0; k < COHSM__STEP; k++) {
        u = (0.5f + cohsm__atan2(z[k], x[k]) * 0.159154943f) * top0;
        v = cohsm__acos_rooted(height[k], root[k]) * 0.318309886f * top1;
        u = cohsm__either(u >= 0.0f, u, 0.0f);
        v = cohsm__either(v >= 0.0f, v, 0.0f);
        u = cohsm__either(u > top0, top0, u) - 0.5f + s->jitter[0][k];
        v = cohsm__either(v > top1, top1, v) - 0.5f + s->jitter[1][k];
        s->at[0][k] = u;
        s->at[1][k] = v;
        c0 = (int32_t)u;
        c1 = (int32_t)v;
        s->cell[0][k] = c0 - ((float)c0 > u);
        s->cell[1][k] = c1 - ((float)c1 > v);
    }
}

/* Does what cohsm__wrap_cell does. */
static inline COHSM__IN_KERNEL void cohsm__step_wrap(cohsm__step *s, const cohsm_maps *m)
{
    int32_t n0 = (int32_t)m->head.side[0], n1 = (int32_t)m->head.side[1], c0, c1;
    int k;

    for (k = 0; k < COHSM__STEP; k++) {
        c0 = s->cell[0][k];
        c1 = s->cell[1][k];
        c0 += n0 / 2 & (0 - ((c1 < 0) | (c1 >= n1)));
        c0 += n0 & (0 - (c0 < 0));
        c0 -= n0 & (0 - (c0 >= n0));
        s->cell[0][k] = c0;
        s->cell[1][k] = c1 + (c1 < 0) - (c1 >= n1);
    }
}

/* Does what cohsm__cell_axes does. */
static inline COHSM__IN_KERNEL void cohsm__step_axes(cohsm__step *s, const cohsm_maps *m)
{
    const float *columns = m->angles, *rows = m->angles + 2 * m->head.side[0];
    int k, two_poles = m->head.orientation == COHSM_ORIENTATION_TWO_POLES;

    for (k = 0; k < COHSM__STEP; k++) {
        s->angle[0][k] = columns[2 * s->cell[0][k]];
        s->angle[1][k] = columns[2 * s->cell[0][k] + 1];
        s->angle[2][k] = rows[2 * s->cell[1][k]];
        s->angle[3][k] = rows[2 * s->cell[1][k] + 1];
    }
    for (k = 0; k < COHSM__STEP; k++) {
        float cp = s->angle[0][k], sp = s->angle[1][k], ct = s->angle[2][k], st = s->angle[3][k];
        s->right[0][k] = -sp;
        s->right[1][k] = 0.0f;
        s->right[2][k] = cp;
        s->up[0][k] = -ct * cp;
        s->up[1][k] = st;
        s->up[2][k] = -ct * sp;
        s->back[0][k] = st * cp;
        s->back[1][k] = ct;
        s->back[2][k] = st * sp;
    }
    if (m->head.orientation == COHSM_ORIENTATION_POLAR) return;
    for (k = 0; k < COHSM__STEP; k++) {
        float x = s->back[0][k], y = s->back[1][k], z = s->back[2][k];
        float a, g, odd;
        g = cohsm__either(!two_poles | (y >= 0.0f), 1.0f, -1.0f);
        odd = fabsf(g + y) < 1e-6f ? 1.0f : 0.0f;
        a = -1.0f / (g + y + odd);
        a = odd > 0.0f ? 0.0f : a;
        s->right[0][k] = 1.0f + g * x * x * a;
        s->right[1][k] = odd > 0.0f ? 0.0f : -g * x;
        s->right[2][k] = g * x * z * a;
        s->up[0][k] = x * z * a;
        s->up[1][k] = odd > 0.0f ? 0.0f : -z;
        s->up[2][k] = g + z * z * a;
    }
}

/* Does what cohsm__project_point does, and moves the samples. */
static inline COHSM__IN_KERNEL void cohsm__step_project(cohsm__step *s, const cohsm__tile *t, size_t first)
{
    const float *px = t->point[0] + first, *py = t->point[1] + first, *pz = t->point[2] + first;
    float top = (float)t->maps->head.map_side, half = 0.5f * top, bias = t->query->bias / top;
    float x, y, d;
    int k;

    for (k = 0; k < COHSM__STEP; k++) {
        x = (px[k] * s->right[0][k] + py[k] * s->right[1][k] + pz[k] * s->right[2][k]) * half + half;
        y = (px[k] * s->up[0][k] + py[k] * s->up[1][k] + pz[k] * s->up[2][k]) * half + half;
        d = px[k] * s->back[0][k] + py[k] * s->back[1][k] + pz[k] * s->back[2][k];
        s->depth[k] = (0.5f - 0.5f * d - bias) * (float)COHSM__HIT_MAX;
        s->at[2][k] = x + (s->jitter[3][k] - 0.5f);
        s->at[3][k] = y + (s->jitter[4][k] - 0.5f);
    }
}

/* Does what cohsm__pixel and cohsm__compared_depth do. Points outside the map, in front of it or not finite
   get COHSM__NO_PIXEL. */
static inline COHSM__IN_KERNEL void cohsm__step_pixels(const cohsm__step *s, cohsm__tile *t, size_t first)
{
    const cohsm_maps *m = t->maps;
    float top = (float)m->head.map_side, x, y, d;
    int32_t side = (int32_t)m->head.map_side, in, p;
    int32_t begin = (int32_t)m->head.pixel_begin, end = begin + (int32_t)m->range;
    int k;

    for (k = 0; k < COHSM__STEP; k++) {
        x = s->at[2][k];
        y = s->at[3][k];
        d = s->depth[k];
        in = s->valid[k] & (x >= 0.0f) & (x < top) & (y >= 0.0f) & (y < top) & (d >= 0.0f);
        x = in ? x : 0.0f;
        y = in ? y : 0.0f;
        d = in ? d : 0.0f;
        p = (int32_t)y * side + (int32_t)x;
        in &= (p >= begin) & (p < end);
        t->pixel[first + (size_t)k] = in ? (uint32_t)(p - begin) : COHSM__NO_PIXEL;
        t->depth[first + (size_t)k] = (int32_t)(d < 65535.0f ? d : 65535.0f);
    }
}

static inline COHSM__IN_KERNEL void cohsm__step_places(const cohsm__step *s, cohsm__tile *t, size_t first)
{
    const cohsm_maps *m = t->maps;
    uint32_t *place = t->place + first;
    uint32_t n0 = m->head.side[0], n1 = m->head.side[1], c0, c1;
    int k;

    if (m->head.order == COHSM_ORDER_HILBERT)
        for (k = 0; k < COHSM__STEP; k++)
            place[k] = cohsm__place_of_cell(m, (uint32_t)s->cell[0][k], (uint32_t)s->cell[1][k], 0);
    else if (m->head.order == COHSM_ORDER_ZIGZAG_THETA)
        for (k = 0; k < COHSM__STEP; k++) {
            c0 = (uint32_t)s->cell[0][k];
            c1 = (uint32_t)s->cell[1][k];
            place[k] = c0 * n1 + (c0 & 1u ? n1 - 1u - c1 : c1);
        }
    else {
        uint32_t zigzag = m->head.order == COHSM_ORDER_ZIGZAG;
        for (k = 0; k < COHSM__STEP; k++) {
            c0 = (uint32_t)s->cell[0][k];
            c1 = (uint32_t)s->cell[1][k];
            place[k] = c1 * n0 + (c1 & zigzag ? n0 - 1u - c0 : c0);
        }
    }
}

/* Moves samples as their filter wants. NEAREST takes the cell and the pixel that a sample lies in; ROULETTE
   takes those that hold the sample after it was moved at random by up to half a step; PCF takes the lowest of
   sixteen, and adds the steps from there. */
static inline COHSM__IN_KERNEL void cohsm__step_jitter(cohsm__step *s, const cohsm__tile *t, size_t first)
{
    static const uint32_t dimension[4] = { 0, 1, 3, 4 };
    cohsm_filter filter = t->query->filter;
    uint32_t i, d;
    int k;

    for (i = 0; i < 4; i++) {
        d = dimension[i];
        if (filter == COHSM_FILTER_ROULETTE)
            for (k = 0; k < COHSM__STEP; k++)
                s->jitter[d][k] = cohsm__random(t->seed, (uint32_t)t->id[first + (size_t)k], d);
        else for (k = 0; k < COHSM__STEP; k++) s->jitter[d][k] = filter == COHSM_FILTER_PCF ? 0.0f : 0.5f;
    }
}

/* Finds cell, pixel and depth of every sample of a tile. */
COHSM__KERNEL COHSM__FLATTEN static void cohsm__address_latlong(cohsm__tile *t)
{
    cohsm__step s;
    size_t first;

    for (first = 0; first < t->count; first += COHSM__STEP) {
        cohsm__step_jitter(&s, t, first);
        cohsm__step_lights(&s, t, first);
        cohsm__step_wrap(&s, t->maps);
        cohsm__step_axes(&s, t->maps);
        cohsm__step_project(&s, t, first);
        cohsm__step_pixels(&s, t, first);
        cohsm__step_places(&s, t, first);
    }
}

#ifndef COHSM_WITHOUT_SIMD
/* Keeps two coordinates of a step, cells of the domain or pixels, as fractions of PCF: the lower one, and how
   far the samples lie towards the next. There are at most 4096 cells or pixels: what is far outside may lie
   anywhere outside. */
static inline COHSM__IN_KERNEL void cohsm__step_fractions(float (*at)[COHSM__STEP], size_t first,
                                                          int16_t (*low)[COHSM__TILE],
                                                          float (*weight)[COHSM__TILE])
{
    float x;
    int32_t l;
    int i, k;

    for (i = 0; i < 2; i++)
        for (k = 0; k < COHSM__STEP; k++) {
            x = cohsm__either(fabsf(at[i][k]) < 8192.0f, at[i][k], -9.0f);
            l = (int32_t)x;
            l -= (float)l > x;
            low[i][first + (size_t)k] = (int16_t)l;
            weight[i][first + (size_t)k] = x - (float)l;
        }
}

/* For PCF: the cells below the lights of a tile, once for the four maps around each. */
COHSM__KERNEL COHSM__FLATTEN static void cohsm__cells_latlong(cohsm__tile *t)
{
    cohsm__fractions *f = &t->work.fractions;
    cohsm__step s;
    size_t first, k;

    for (first = 0; first < t->count; first += COHSM__STEP) {
        cohsm__step_jitter(&s, t, first);
        cohsm__step_lights(&s, t, first);
        cohsm__step_fractions(s.at, first, f->cell, f->weight);
        for (k = 0; k < COHSM__STEP; k++) f->valid[first + k] = (uint8_t)s.valid[k];
    }
}

/* For PCF: places and depths in one of the four maps around each light, whose bits 0 and 1 choose the cell,
   and the pixels below, once for the four around each sample. Samples without an answer get a depth of -1. */
COHSM__KERNEL COHSM__FLATTEN static void cohsm__project_latlong(cohsm__tile *t, uint32_t map)
{
    cohsm__fractions *f = &t->work.fractions;
    cohsm__step s;
    size_t first, k;
    float d;

    for (first = 0; first < t->count; first += COHSM__STEP) {
        for (k = 0; k < COHSM__STEP; k++) {
            s.cell[0][k] = f->cell[0][first + k] + (int32_t)(map & 1u);
            s.cell[1][k] = f->cell[1][first + k] + (int32_t)(map >> 1);
            s.jitter[3][k] = s.jitter[4][k] = 0.0f;
        }
        cohsm__step_wrap(&s, t->maps);
        cohsm__step_axes(&s, t->maps);
        cohsm__step_project(&s, t, first);
        cohsm__step_places(&s, t, first);
        cohsm__step_fractions(s.at + 2, first, f->pixel, f->weight + 2);
        for (k = 0; k < COHSM__STEP; k++) {
            d = cohsm__either((f->valid[first + k] != 0) & (s.depth[k] >= 0.0f), s.depth[k], -1.0f);
            t->depth[first + k] = (int32_t)(d < 65535.0f ? d : 65535.0f);
        }
    }
}

/* For PCF: one of the four pixels around each sample, which bits 0 and 1 of the corner choose. */
COHSM__KERNEL static void cohsm__corner_latlong(cohsm__tile *t, uint32_t corner)
{
    const cohsm__fractions *f = &t->work.fractions;
    const uint32_t side = t->maps->head.map_side, begin = t->maps->head.pixel_begin, range = t->maps->range;
    size_t i;

    for (i = 0; i < t->count; i++) {
        const uint32_t x = (uint32_t)(int32_t)f->pixel[0][i] + (corner & 1u);
        const uint32_t y = (uint32_t)(int32_t)f->pixel[1][i] + (corner >> 1);
        const uint32_t p = y * side + x - begin;
        const int in = (x < side) & (y < side) & (p < range) & (t->depth[i] >= 0);
        t->pixel[i] = in ? p : COHSM__NO_PIXEL;
    }
}
#endif

#endif
