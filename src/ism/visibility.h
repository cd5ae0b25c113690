/* ---- visibility: depths of the tiles compared ---- */

/* Returns where a VPL's tile begins in the atlas. */
static const float *ism__tile_of(const ism_maps *m, uint32_t v)
{
    size_t column = v % m->tiles, row = v / m->tiles;
    return (const float *)m->atlas.data + row * m->desc.tile_side * m->side + column * m->desc.tile_side;
}

/* A receiver as seen from a VPL, before the texel of the map is read. Looks of several VPLs are made
   together, so that their texels, which no cache holds, are fetched meanwhile. */
typedef struct ism__look {
    ism__v3      l, n;              /* the receiver and its normal along the axes of the VPL's map */
    float        d;                 /* distance from the VPL; depth in a map of directions */
    uint32_t     x, y;              /* texel */
    const float *at;                /* the texel's depth; NULL: `lit` is known without it */
    int          lit;
} ism__look;

/* Finds the texel that shows a receiver. A VPL behind the receiver's tangent plane is hidden by the
   receiver's own surface; the depth of a thin sheet could not tell its two sides apart. */
static void ism__look_at(const ism_maps *m, uint32_t number, const ism__orientation *f, ism__v3 p, ism__v3 ng,
                         ism__look *look)
{
    uint32_t size = m->desc.tile_side;
    const ism_vpl *v = &m->vpls[number];
    const ism__window *w = (const ism__window *)m->windows.data + number;
    float uv[2], direction[3];
    look->at = NULL;
    look->n = ism__to_local(f, ng);
    if (v->directional) {
        float r = m->radius;
        look->l = ism__to_local(f, ism__v3_sub(p, ism__v3_load(m->center)));
        look->d = look->l.z + r;
        uv[0] = 0.5f * look->l.x / r + 0.5f;
        uv[1] = 0.5f * look->l.y / r + 0.5f;
        look->lit = look->n.z < -ISM__GRAZING;
        if (!look->lit || !(uv[0] >= 0.0f && uv[1] >= 0.0f && uv[0] < 1.0f && uv[1] < 1.0f)) return;
    } else {
        look->l = ism__to_local(f, ism__v3_sub(p, ism__v3_load(v->position)));
        look->d = ism__v3_length(look->l);
        look->lit = 1;
        if (!(look->l.z > 0.0f) || !(look->d > 0.0f)) return;
        look->lit = ism__v3_dot(look->n, look->l) < -ISM__GRAZING * look->d;
        if (!look->lit) return;
        ism__v3_store(direction, ism__v3_scale(look->l, 1.0f / look->d));
        if (!ism_map_coordinates(ism__projection_of(m, v), v->exponent, direction, uv)) return;
    }
    look->x = ism__texel_of(ism__to_tile(&w->u, uv[0]), size);
    look->y = ism__texel_of(ism__to_tile(&w->v, uv[1]), size);
    look->at = ism__tile_of(m, number) + (size_t)look->y * m->side + look->x;
    ISM__PREFETCH(look->at);
}

/* Returns whether the map lets light through to a receiver. Depths are compared at the centre of the texel,
   on the receiver's own tangent plane: so grazing light leaves no acne. */
static int ism__is_lit(const ism_maps *m, uint32_t number, const ism__look *look, float bias)
{
    uint32_t size = m->desc.tile_side;
    const ism_vpl *v = &m->vpls[number];
    const ism__window *w = (const ism__window *)m->windows.data + number;
    ism__v3 l = look->l, n = look->n;
    float d = look->d, uv[2], direction[3];
    float along, t;
    if (!look->at) return look->lit;
    t = *look->at;
    if (!v->directional && d * (1.0f - bias) <= t && t >= 2.0f * d) return 1;
    uv[0] = ism__from_tile(&w->u, ((float)look->x + 0.5f) / (float)size);
    uv[1] = ism__from_tile(&w->v, ((float)look->y + 0.5f) / (float)size);
    if (v->directional) {
        float r = m->radius, dx = (2.0f * uv[0] - 1.0f) * r - l.x, dy = (2.0f * uv[1] - 1.0f) * r - l.y;
        if (fabsf(n.z) > 0.1f) d -= (n.x * dx + n.y * dy) / n.z;
        return d - bias * r <= t;
    }
    if (0.5f * d * (1.0f - bias) > t) return 0;     /* the plane's depth, below, is at least 0.5 d */
    if (ism__projection_of(m, v) != ISM_PROJECTION_LOBE && !w->u.on && !w->v.on) {
        const float *at = (const float *)m->directions.data + (size_t)look->y * size + look->x;
        size_t texels = (size_t)size * size;
        direction[0] = at[0];
        direction[1] = at[texels];
        direction[2] = at[2u * texels];
    } else {
        ism_map_direction(ism__projection_of(m, v), v->exponent, uv, direction);
    }
    along = n.x * direction[0] + n.y * direction[1] + n.z * direction[2];
    along = along != 0.0f ? ism__v3_dot(n, l) / along : d;
    if (along > 0.5f * d && along < 2.0f * d) d = along;
    return d * (1.0f - bias) <= t;
}

static int ism__lit(const ism_maps *m, uint32_t number, const ism__orientation *f, ism__v3 p, ism__v3 ng,
                    float bias)
{
    ism__look look;
    ism__look_at(m, number, f, p, ng, &look);
    return ism__is_lit(m, number, &look, bias);
}

/* Returns the bias of a setting: 0 is the default, a negative number is none. */
static float ism__bias_of(float bias) { return bias > 0.0f ? bias : bias < 0.0f ? 0.0f : 0.02f; }

ISM_DEF ism_result ism_visible(const ism_maps *m, uint32_t vpl, const ism_points *points, float bias,
                               float *visible)
{
    ism__orientation axes;
    ism__job job;
    ism_result result;
    size_t i;
    if (!m) return ISM_ERR_ARGUMENT;
    ism__begin_job(&m->desc.system, "ism_visible", NULL, &job);
    if (!visible) return ism__is_null(&job.log, "visible");
    if (vpl >= m->vpl_count || !(bias < 1.0f)) {
        if (vpl >= m->vpl_count) ism__log_value(&job.log, "vpl", (double)vpl, "less than there are VPLs");
        else ism__log_value(&job.log, "bias", (double)bias, "less than 1");
        return ISM_ERR_ARGUMENT;
    }
    if (!m->built) return ism__too_early(&job.log, "maps", "are not drawn: call ism_build before");
    result = ism__open_view(&job.log, points, &job.view);
    if (result != ISM_OK) return result;
    axes = ism__vpl_axes(m, &m->vpls[vpl]);
    for (i = 0; i < points->count; i++) {
        ism__v3 p, n;
        visible[i] = 0.0f;
        if (!ism__receiver(&job.view, i, &p, &n)) continue;
        n = ism__geometric_normal(&job.view, i, n);
        visible[i] = (float)ism__lit(m, vpl, &axes, p, n, ism__bias_of(bias));
    }
    return ISM_OK;
}

ISM_DEF void ism_see(void *sight, const float position[3], const float geometric_normal[3],
                     const uint32_t *numbers, size_t count, float *visible)
{
    const ism_sight *s = (const ism_sight *)sight;
    const ism_maps *m = s->maps;
    const ism__v3 p = ism__v3_load(position), ng = ism__v3_load(geometric_normal);
    ism__look looks[ISM__CHUNK];
    size_t first, i, n;
    for (first = 0; first < count; first += n) {
        n = count - first < ISM__CHUNK ? count - first : (size_t)ISM__CHUNK;
        for (i = 0; i < n && m->built; i++) {
            uint32_t v = numbers[first + i];
            ism__orientation axes;
            if (v >= m->vpl_count) continue;
            axes = ism__vpl_axes(m, &m->vpls[v]);
            ism__look_at(m, v, &axes, p, ng, &looks[i]);
        }
        for (i = 0; i < n; i++) {
            uint32_t v = numbers[first + i];
            visible[first + i] = !m->built ? 0.0f
                               : v < m->vpl_count
                                   ? (float)ism__is_lit(m, v, &looks[i], ism__bias_of(s->bias)) : 1.0f;
        }
    }
}

/* Writes the visibility of `count` VPLs; the list has their places in `order`. */
static void ism__visibilities(const ism__shade_work *w, const ism__pixel *px, const uint32_t *list,
                              uint32_t count, float *visible)
{
    uint32_t i, numbers[ISM__CHUNK];
    ism__look looks[ISM__CHUNK];    /* of all VPLs, so that their texels are fetched before one is read */
    if (w->s.visible_fn) {
        float position[3], geometric[3];
        for (i = 0; i < count; i++) numbers[i] = w->order[list[i]];
        ism__v3_store(position, px->p);
        ism__v3_store(geometric, px->ng);
        w->s.visible_fn(w->s.visible_user, position, geometric, numbers, count, visible);
        return;
    }
    for (i = 0; i < count && !w->s.no_maps; i++)
        ism__look_at(w->m, w->order[list[i]], &w->axes[list[i]], px->p, px->ng, &looks[i]);
    for (i = 0; i < count; i++)
        visible[i] = w->s.no_maps ? 1.0f : (float)ism__is_lit(w->m, w->order[list[i]], &looks[i], w->s.bias);
}

/* Returns the axes of the map of VPL v. */
static const ism__orientation *ism__near_axes(const ism__shade_work *w, uint32_t v)
{
    uint32_t classes = w->interleave * w->interleave;
    return &w->axes[w->class_first[v % classes] + v / classes];
}

/* Returns how much of a near point a receiver sees by the map of the point's VPL. Two kinds of receivers
   count as lit beside those that the map shows as lit: one that the map hides, if the point is nearer than
   the VPL and the map, moved to the point, hides nothing, since surfaces are alike around both; and one
   behind the VPL, where the map ends. Neither does if it faces the point, since it may be the back of a bent
   sheet. */
static float ism__near_lit(const ism__shade_work *w, const ism_near_point *at, const ism__pixel *px,
                           const ism__look *look)
{
    const ism_maps *m = w->m;
    uint32_t v = (uint32_t)at->vpl;
    const ism_vpl *l = &m->vpls[v];
    const ism__orientation *f = ism__near_axes(w, v);
    ism__v3 way = ism__v3_sub(ism__v3_load(l->position), ism__v3_load(at->position));
    ism__v3 d = ism__v3_sub(px->p, ism__v3_load(at->position));
    float facing = -2.0f * ism__v3_dot(px->n, ism__v3_load(at->normal));
    float open = !(facing > 0.0f) ? 1.0f : facing < 1.0f ? 1.0f - facing : 0.0f;
    if (!(ism__v3_dot(f->z, ism__v3_sub(px->p, ism__v3_load(l->position))) > 0.0f)) return open;
    if (ism__is_lit(m, v, look, w->s.bias)) return 1.0f;
    if (!(ism__v3_dot(d, d) < ism__v3_dot(way, way) && ism__v3_dot(f->z, d) > 0.0f)) return 0.0f;
    return ism__lit(m, v, f, ism__v3_add(px->p, way), px->ng, w->s.bias) ? open : 0.0f;
}

/* Writes the visibility of `count` near points of the list. */
static void ism__near_visibilities(const ism__shade_work *w, const ism__pixel *px, const uint32_t *list,
                                   uint32_t count, float *visible)
{
    const ism_near_point *points = (const ism_near_point *)w->m->near_points.data;
    ism_visible_fn fn = w->s.near_visible_fn ? w->s.near_visible_fn : w->s.visible_fn;
    uint32_t i, numbers[ISM__CHUNK];
    ism__look looks[ISM__CHUNK];
    if (fn) {
        float position[3], geometric[3];
        for (i = 0; i < count; i++)
            numbers[i] = w->s.near_visible_fn ? list[i] : (uint32_t)points[list[i]].vpl;
        ism__v3_store(position, px->p);
        ism__v3_store(geometric, px->ng);
        fn(w->s.near_visible_fn ? w->s.near_visible_user : w->s.visible_user, position, geometric, numbers,
           count, visible);
        return;
    }
    for (i = 0; i < count && !w->s.no_maps; i++) {
        uint32_t v = (uint32_t)points[list[i]].vpl;
        ism__look_at(w->m, v, ism__near_axes(w, v), px->p, px->ng, &looks[i]);
    }
    for (i = 0; i < count; i++)
        visible[i] = w->s.no_maps ? 1.0f : ism__near_lit(w, &points[list[i]], px, &looks[i]);
}
