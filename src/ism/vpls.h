/* ---- vpls: drawn from the importances (paper 4.1) ---- */

/* Makes a VPL from one of `count` samples, which was chosen with this probability. */
static void ism__make_vpl(const ism_maps *m, const ism__job *job, size_t source, const ism__cdf2_sample *at,
                          double probability, uint32_t count, ism_vpl *v)
{
    const ism_source *s = &job->frame->sources[source];
    size_t i = (size_t)at->y * s->width + at->x;
    const float *flux = ism__at(s->fluxes, s->flux_stride, i);
    ism__v3 p = ism__v3_load(ism__at(s->positions, s->position_stride, i)), n;
    float scale = (float)(1.0 / ((double)count * probability)), spacing = 0.0f;
    int k;
    memset(v, 0, sizeof *v);
    v->source = (uint32_t)source;
    v->texel = (uint32_t)i;
    v->directional = s->kind == ISM_SOURCE_DIRECTIONS;
    if (v->directional) {
        p = ism__v3_normalize(p);
        n = ism__v3_scale(p, -1.0f);
    } else {
        n = ism__v3_normalize(ism__v3_load(ism__at(s->normals, s->normal_stride, i)));
#ifndef ISM_WITHOUT_INTER_TEXEL
        if (!s->scattered && !m->desc.no_inter_texel) spacing = ism__inter_texel(&job->view, s, at, &p, &n);
#else
        (void)m;
#endif
    }
    ism__v3_store(v->position, p);
    ism__v3_store(v->normal, n);
    ism__v3_store(v->axis, n);
    v->exponent = 1.0f;
    if (s->lobes && !v->directional) {
        ism__v3_store(v->axis, ism__v3_normalize(ism__v3_load(ism__lobe(s, i))));
        v->exponent = ism__lobe(s, i)[3];
    }
    /* The flux of a texel that is almost never chosen is cut off at the most that a VPL may have. */
    for (k = 0; k < 3; k++) v->flux[k] = flux[k] * scale < 1e30f ? flux[k] * scale : 1e30f;
    if (s->areas && !v->directional)
        v->area = *ism__at(s->areas, s->area_stride ? s->area_stride : 4u, i) * scale;
    if (!(v->area >= 0.0f) || !ism__finite(v->area)) v->area = 0.0f;
    v->edge = spacing;      /* the distance to the farthest neighbour, for ism__flag_jumps; ism__edge_task
                               then writes the edge */
}

/* Marks the VPLs that jumped: they are of another source than in the last frame, or farther than a texel from
   where they were. */
static void ism__flag_jumps(ism_maps *m)
{
    const ism_vpl *old = (const ism_vpl *)m->previous.data;
    uint32_t i;
    m->stats.jumped = 0;
    for (i = 0; i < m->vpl_count; i++) {
        ism_vpl *v = &m->vpls[i];
        float limit = v->edge;
        ism__v3 d;
        if (i >= m->previous_count) continue;
        d = ism__v3_sub(ism__v3_load(v->position), ism__v3_load(old[i].position));
        v->jumped = v->source != old[i].source || ism__v3_dot(d, d) > limit * limit;
        m->stats.jumped += (uint32_t)v->jumped;
    }
}

/* Finds the edge of the square that a VPL becomes for receivers near by. The square has the VPL's area, but
   reaches no farther than its neighbours are. VPLs at one place, of a texel that was chosen twice, share a
   square of their areas' sum: two squares of one's area would be twice as bright as the surface. */
static void ism__edge_task(void *context, size_t index)
{
    ism_maps *m = (ism_maps *)context;
    ism_vpl *v = &m->vpls[index];
    ism__v3 p = ism__v3_load(v->position), n = ism__v3_load(v->normal);
    float near2[4] = { 1e30f, 1e30f, 1e30f, 1e30f }, most, area = v->area;
    uint32_t i, k;
    v->edge = 0.0f;
    if (v->directional || v->exponent != 1.0f) return;
    for (i = 0; i < m->vpl_count; i++) {
        const ism_vpl *o = &m->vpls[i];
        ism__v3 d = ism__v3_sub(ism__v3_load(o->position), p);
        float d2 = ism__v3_dot(d, d);
        if (i == index || d2 >= near2[3] || o->directional) continue;
        if (ism__v3_dot(n, ism__v3_load(o->normal)) < 0.5f) continue;
        if (!(d2 > 0.0f)) {
            area += o->area;
            continue;
        }
        for (k = 3; k > 0 && near2[k - 1u] > d2; k--) near2[k] = near2[k - 1u];
        near2[k] = d2;
    }
    most = near2[3] < 1e30f ? ISM__PI * near2[3] : 0.0f;
    area = area > 0.0f ? (most > 0.0f && area > 2.0f * most ? 2.0f * most : area) : 0.25f * most;
    v->edge = sqrtf(area);
}

/* Finds the squares of VPLs that were chosen or set, which have no near points yet. */
static ism_result ism__finish_vpls(ism_maps *m, const ism__part *part, float from, float to)
{
    uint32_t i;
    for (i = 0; i < m->vpl_count; i++) m->vpls[i].reach = 0.0f;
    m->near_count = m->stats.near_points = 0;
    if (!ism__run(m, part, from, to, m->vpl_count, ism__edge_task, m))
        return m->chosen = 0, ISM_ERR_CANCELLED;
    m->stats.vpls = m->vpl_count;
    m->chosen = 1;
    return ISM_OK;
}

/* Draws sample i of count at ((i + 0.5) / count, golden ratio sequence): the first number chooses source and
   row, the second the column. Returns 0 if there is no such sample. */
static int ism__draw_vpl(const ism_maps *m, const ism__job *job, double total, uint32_t i, uint32_t count,
                     uint32_t stream, ism_vpl *v)
{
    const ism__source_of *of = (const ism__source_of *)m->sources.data;
    const ism_frame *f = job->frame;
    uint32_t key = m->desc.unstable ? ism__hash_combine(m->desc.seed, f->index) : m->desc.seed;
    uint32_t shift_u = ism__hash_combine(key, stream), shift_v = ism__hash_combine(key, stream + 1u);
    double u = ((double)i + 0.5) / (double)count + (m->desc.unstable ? (double)ism__to_unit(shift_u) : 0.0),
           rest;
    ism__cdf2_sample at;
    ism__cdf2 cdf;
    size_t s = 0, last = 0, k;
    u = (u - floor(u)) * total;
    for (k = 0; k < f->source_count; k++)
        if (of[k].total > 0.0) last = k;
    rest = u;
    for (s = 0; s < last && !(rest < of[s].total); s++) rest -= of[s].total;
    cdf.rows = (const double *)m->cdf.data + of[s].cdf_first;
    cdf.sums = cdf.rows + f->sources[s].height + 1u;
    cdf.width = f->sources[s].width;
    cdf.height = f->sources[s].height;
    at = ism__cdf2_sample_at(&cdf, ism__to_unit(i * 2654435769u + shift_v), (float)(rest / of[s].total));
    if (!(at.probability > 0.0f)) return 0;
    ism__make_vpl(m, job, s, &at, (double)at.probability * of[s].total / total, count, v);
    return 1;
}

/* Draws the VPLs in proportion to the importances, whose sum is `total`. */
static void ism__draw_all_vpls(ism_maps *m, const ism__job *job, double total)
{
    uint32_t n = m->desc.vpl_count, i;
    m->vpl_count = 0;
    for (i = 0; i < n && total > 0.0; i++)
        m->vpl_count += (uint32_t)ism__draw_vpl(m, job, total, i, n, 11u, &m->vpls[m->vpl_count]);
}
