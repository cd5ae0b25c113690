/* ---- choose: the stage of section 4, and what it leaves ---- */

/* Makes room for the importances and near points of sources with this many texels. Returns 0 if there is no
   memory. */
static int ism__grow_choice(ism_maps *m, size_t sources, size_t cells, size_t doubles)
{
    return ism__grow(m, &m->sources, sources, sizeof(ism__source_of)) &&
           ism__grow(m, &m->importance, cells, sizeof(float)) &&
           ism__grow(m, &m->blurred, 2u * cells, sizeof(float)) &&
#ifndef ISM_WITHOUT_NEAR_POINTS
           ism__grow(m, &m->cdf, doubles, sizeof(double)) && ism__grow_near(m);
#else
           ism__grow(m, &m->cdf, doubles, sizeof(double));
#endif
}

/* Computes the importances of all sources, up to 0.7 of the call's progress. */
static ism_result ism__weigh_sources(ism_maps *m, const ism__job *job, size_t cells, ism__source_of *of)
{
    const ism_frame *f = job->frame;
    uint32_t seed = m->desc.unstable ? ism__hash_combine(m->desc.seed, f->index) : m->desc.seed;
    size_t s, first = 0, cdf_first = 0;
    ism__choice c;
    memset(&c, 0, sizeof c);
    c.m = m;
    c.job = job;
    c.extent = ism__extent(&job->view);
    c.by_mean = m->desc.importance == ISM_IMPORTANCE_BRSM_MEAN ||
                m->desc.importance == ISM_IMPORTANCE_GUIDED_MEAN;
    m->stats.bad_pvpls = 0;
    m->stats.flux[0] = m->stats.flux[1] = m->stats.flux[2] = 0.0;
    for (s = 0; s < f->source_count; s++) {
        const ism_source *src = &f->sources[s];
        size_t texels = (size_t)src->width * src->height;
        ism_result result;
        c.source = s;
        c.seed = ism__hash_combine(seed, (uint32_t)s);
        c.out = (float *)m->importance.data + first;
        c.lum = (float *)m->blurred.data + first;
        c.effect = c.lum + cells;
        c.from = 0.7f * (float)first / (float)cells;
        c.to = 0.7f * (float)(first + texels) / (float)cells;
        of[s].first = first;
        of[s].cdf_first = cdf_first;
        result = ism__weigh_source(&c, src, &of[s].flux);
        if (result != ISM_OK) return result;
        first += texels;
        cdf_first += ism__cdf2_doubles(src->width, src->height);
    }
    c.out = (float *)m->importance.data;
    c.lum = (float *)m->blurred.data;
    ism__add_shares(&c, of);
    return ISM_OK;
}

/* Makes prefix sums of the importances, and returns the sum of all. */
static double ism__sum_importances(ism_maps *m, const ism_frame *f, ism__source_of *of)
{
    double total = 0.0;
    size_t s;
    for (s = 0; s < f->source_count; s++) {
        const ism_source *src = &f->sources[s];
        ism__cdf2 cdf;
        ism__cdf2_build(&cdf, (double *)m->cdf.data + of[s].cdf_first,
                        (float *)m->importance.data + of[s].first, NULL, src->width, src->height);
        of[s].total = ism__cdf2_total(&cdf);
        total += of[s].total;
    }
    return total;
}

static ism_result ism__choose(ism_maps *m, const ism__job *job)
{
    const ism_frame *f = job->frame;
    ism__source_of *of;
    size_t cells, doubles;
    double total;
    ism_result result = ism__check_sources(&job->log, f, &cells, &doubles);
    if (result != ISM_OK) return result;
    m->source_count = 0;
    if (!ism__grow_choice(m, f->source_count, cells, doubles)) return ism__no_memory(&job->log);
    of = (ism__source_of *)m->sources.data;
    result = ism__weigh_sources(m, job, cells, of);
    if (result != ISM_OK) return m->chosen = 0, result;
    m->source_count = f->source_count;
    m->cells = cells;
    total = ism__sum_importances(m, f, of);
    m->previous_count = m->chosen ? m->vpl_count : 0;
    memcpy(m->previous.data, m->vpls, m->previous_count * sizeof *m->vpls);
    ism__draw_all_vpls(m, job, total);
    ism__flag_jumps(m);
    m->built = 0;
    result = ism__finish_vpls(m, &job->part, 0.7f, 0.8f);
#ifndef ISM_WITHOUT_NEAR_POINTS
    if (result == ISM_OK) return ism__draw_near(m, job, total, 0.8f, 1.0f);
#endif
    return result;
}

/* Begins a call that is given a frame: fills job, and checks the frame's receivers. */
static ism_result ism__open_frame(const ism_maps *m, const ism_frame *f, const char *function, ism__job *job)
{
    if (!m) return ISM_ERR_ARGUMENT;
    ism__begin_job(&m->desc.system, function, f, job);
    if (!f) return ism__is_null(&job->log, "frame");
    return ism__open_view(&job->log, f->points, &job->view);
}

ISM_DEF ism_result ism_choose(ism_maps *m, const ism_frame *f)
{
    ism__job job;
    ism_result result = ism__open_frame(m, f, "ism_choose", &job);
    return result == ISM_OK ? ism__choose(m, &job) : result;
}

/* Logs "vpls[INDEX].FIELD is VALUE; it must be WANTED", and returns ISM_ERR_INPUT. */
static ism_result ism__bad_vpl(const ism__logger *log, size_t index, const char *field, float value,
                               const char *wanted)
{
    ism__message name;
    name.used = 0;
    ism__message_text(&name, "vpls[");
    ism__message_count(&name, index);
    ism__message_text(&name, "].");
    ism__message_text(&name, field);
    ism__log_value(log, name.text, (double)value, wanted);
    return ISM_ERR_INPUT;
}

static ism_result ism__check_vpl(const ism__logger *log, const ism_vpl *v, size_t i)
{
    static const char unit[] = "1 (0.97..1.03)", *const positions[] = { "position[0]", "position[1]",
                                                                        "position[2]" };
    static const char *const fluxes[] = { "flux[0]", "flux[1]", "flux[2]" };
    ism__v3 normal = ism__v3_load(v->normal), axis = ism__v3_load(v->axis);
    int k;
    for (k = 0; k < 3; k++) {
        if (!ism__finite(v->position[k])) return ism__bad_vpl(log, i, positions[k], v->position[k], "finite");
        if (!ism__in(v->flux[k], 0.0f, 1e30f)) return ism__bad_vpl(log, i, fluxes[k], v->flux[k], "0..1e30");
    }
    if (ism__unit_kind(normal) <= 0)
        return ism__bad_vpl(log, i, "normal's length", ism__v3_length(normal), unit);
    if (ism__unit_kind(axis) <= 0) return ism__bad_vpl(log, i, "axis's length", ism__v3_length(axis), unit);
    if (!ism__in(v->exponent, 0.0f, 1e5f)) return ism__bad_vpl(log, i, "exponent", v->exponent, "0..1e5");
    if (!ism__in(v->area, 0.0f, ISM__MAX_FLOAT))
        return ism__bad_vpl(log, i, "area", v->area, "finite and not negative");
    return ISM_OK;
}

ISM_DEF ism_result ism_set_vpls(ism_maps *m, const ism_vpl *vpls, size_t count)
{
    ism__job job;
    size_t i;
    if (!m) return ISM_ERR_ARGUMENT;
    ism__begin_job(&m->desc.system, "ism_set_vpls", NULL, &job);
    if (!vpls && count) return ism__is_null(&job.log, "vpls");
    if (count > m->desc.vpl_count) {
        ism__log_value(&job.log, "count", (double)count, "desc.vpl_count at most");
        return ISM_ERR_LIMIT;
    }
    for (i = 0; i < count; i++) {
        ism_result result = ism__check_vpl(&job.log, &vpls[i], i);
        if (result != ISM_OK) return result;
    }
    if (count) memcpy(m->vpls, vpls, count * sizeof *vpls);
    m->vpl_count = (uint32_t)count;
    m->stats.jumped = 0;
    m->built = 0;
    return ism__finish_vpls(m, &job.part, 0.0f, 1.0f);
}

ISM_DEF const ism_vpl *ism_vpls(const ism_maps *m, size_t *count)
{
    if (count) *count = m ? m->vpl_count : 0;
    return m ? m->vpls : NULL;
}

ISM_DEF const ism_near_point *ism_near_points(const ism_maps *m, size_t *count)
{
    if (count) *count = m ? m->near_count : 0;
    return m && m->near_count ? (const ism_near_point *)m->near_points.data : NULL;
}

ISM_DEF const float *ism_importances(const ism_maps *m, size_t source, size_t *count)
{
    const ism__source_of *of;
    if (!m || !m->chosen || source >= m->source_count) return NULL;
    of = (const ism__source_of *)m->sources.data;
    if (count) *count = (source + 1u < m->source_count ? of[source + 1u].first : m->cells) -
                        of[source].first;
    return (const float *)m->importance.data + of[source].first;
}
