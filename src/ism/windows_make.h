/* ---- windows: where the picture lies in the squares of VPLs ---- */

/* Writes where a place lies in the VPL's square. Returns 0 if the place is not before the VPL, or outside a
   map of directions. */
static int ism__square_of(const ism_maps *m, const ism_vpl *v, const ism__orientation *f, ism__v3 p,
                          float uv[2])
{
    ism__v3 l = ism__to_local(f, ism__v3_sub(p, ism__v3_load(v->directional ? m->center : v->position)));
    float d, direction[3];
    if (v->directional) {
        uv[0] = 0.5f * l.x / m->radius + 0.5f;
        uv[1] = 0.5f * l.y / m->radius + 0.5f;
        return uv[0] >= 0.0f && uv[1] >= 0.0f && uv[0] < 1.0f && uv[1] < 1.0f;
    }
    d = ism__v3_length(l);
    if (!(d > 0.0f) || !ism__finite(d)) return 0;
    ism__v3_store(direction, ism__v3_scale(l, 1.0f / d));
    return ism_map_coordinates(ism__projection_of(m, v), v->exponent, direction, uv);
}

typedef struct ism__window_work {
    ism_maps       *m;
    const ism__view *view;
    uint32_t        rows, columns, count, seen[8u * ISM__SIGHTS];
} ism__window_work;

/* Finds the receivers of one block that lie farthest in eight directions, such as the corners of a wall: a
   window that holds them holds nearly all others. A receiver that was found before is UINT32_MAX. */
static void ism__sight_task(void *context, size_t index)
{
    ism__window_work *w = (ism__window_work *)context;
    const ism__view *view = w->view;
    uint32_t row = (uint32_t)index / w->columns, column = (uint32_t)index % w->columns,
             *best = w->seen + 8u * index;
    uint32_t k, j;
    size_t x, y, x1 = (size_t)view->width * (column + 1u) / w->columns,
                 y1 = (size_t)view->height * (row + 1u) / w->rows;
    float most[8];
    memset(best, 255, 8u * sizeof *best);
    for (y = (size_t)view->height * row / w->rows; y < y1; y++)
        for (x = (size_t)view->width * column / w->columns; x < x1; x++) {
            ism__v3 p, n;
            size_t i = y * view->width + x;
            if (!ism__receiver(view, i, &p, &n)) continue;
            for (k = 0; k < 8u; k++) {      /* unequal weights: no two points of a grid lie equally far */
                float at =
                    (k & 1u ? p.x : -p.x) + 0.9f * (k & 2u ? p.y : -p.y) + 1.1f * (k & 4u ? p.z : -p.z);
                if (best[k] != UINT32_MAX && !(at > most[k])) continue;
                most[k] = at;
                best[k] = (uint32_t)i;
            }
        }
    for (k = 1; k < 8u; k++)
        for (j = 0; j < k; j++)
            if (best[j] == best[k]) best[k] = UINT32_MAX;
}

/* Returns where one side of the new window lies: where it was in the frame before, if that is no more than
   ISM__SLACK farther out than needed, so that windows seldom change while things move; else where it is
   needed. */
static uint32_t ism__cut_at(uint32_t need, uint32_t was, int known)
{
    return known && was <= need && was + ISM__SLACK >= need ? was : need;
}

static void ism__window_task(void *context, size_t index)
{
    const ism__window_work *w = (const ism__window_work *)context;
    ism_maps *m = w->m;
    ism_vpl *v = &m->vpls[index];
    uint32_t *was = (uint32_t *)(void *)((ism__window *)m->windows.data + m->desc.vpl_count) + index;
    float lo[2] = { 1.0f, 1.0f }, hi[2] = { 0.0f, 0.0f };
    uint32_t i, k;
    int known = index < m->window_count && !v->jumped && !m->desc.unstable;
    ism__window *out = (ism__window *)m->windows.data + index;
    ism__orientation f = ism__vpl_axes(m, v);
    v->window = 0;
    for (i = 0; i < w->count; i++) {
        ism__v3 p, n;
        float uv[2];
        if (w->seen[i] == UINT32_MAX || !ism__receiver(w->view, w->seen[i], &p, &n)) continue;
        n = ism__geometric_normal(w->view, w->seen[i], n);
        if (!(ism__v3_dot(n, v->directional ? f.z : ism__v3_sub(p, ism__v3_load(v->position))) < 0.0f) ||
            !ism__square_of(m, v, &f, p, uv))
            continue;
        for (k = 0; k < 2u; k++) {
            lo[k] = uv[k] < lo[k] ? uv[k] : lo[k];
            hi[k] = uv[k] > hi[k] ? uv[k] : hi[k];
        }
    }
    if (lo[0] <= hi[0])             /* else no receiver looks at this map */
        for (k = 0; k < 2u; k++) {
            float pad = (hi[k] - lo[k]) * ISM__PAD;
            uint32_t low = ism__texel_of(lo[k] > pad ? lo[k] - pad : 0.0f, ISM__STEPS);
            uint32_t high = ISM__STEPS - 1u - ism__texel_of(hi[k] + pad, ISM__STEPS);
            v->window |= ism__cut_at(low, *was >> 6u * k & 63u, known) << 6u * k;
            v->window |= ism__cut_at(high, *was >> (6u * k + 12u) & 63u, known) << (6u * k + 12u);
        }
    *was = v->window;
    ism__set_window(v->window, m->desc.tile_side, (uint32_t)m->desc.window_rim, out);
    if (!out->u.on && !out->v.on) v->window = 0;
}

/* Makes the windows of all tiles. Maps for ism_bounce have none: light that bounces on counts, seen or not.
   Returns 0 if the caller cancels. */
static int ism__make_windows(ism_maps *m, const ism__view *view, const ism__part *part)
{
    ism__window_work w;
    w.m = m;
    w.view = view;
    w.rows = view->height < 8u ? 1u : 8u;
    w.columns = ISM__SIGHTS / w.rows;
    w.count = !m->desc.window_rim || m->desc.keep_hits ? 0 : 8u * ISM__SIGHTS;
    if ((w.count && !ism__run(m, part, 0.0f, 0.05f, ISM__SIGHTS, ism__sight_task, &w)) ||
        !ism__run(m, part, 0.05f, 0.1f, m->vpl_count, ism__window_task, &w))
        return 0;
    m->window_count = m->vpl_count;
    return 1;
}
