/* ---- shading: the public calls ---- */

static void sfield__shade_set_sh(const sfield__job *job, const sfield_points *set, size_t piece,
                                 uint8_t *memory, sfield_scene_stats *stats)
{
    const sfield_scene *s = job->s;
    const uint64_t hash = sfield__hash_set(s, set);
    sfield__tile t;
    size_t i;
    memset(&t, 0, sizeof t);
    t.s = s;
    t.set = set;
    t.lights = s->light_count;
    t.sky = s->has_sky || s->has_sun || set->ambient;
    t.chains = 1;
#ifndef SFIELD_WITHOUT_GLOSS
    t.chains = sfield__count_chains(set);
#endif
    t.all_round = job->incident != NULL;
    t.set_hash = hash;
    t.stats = *stats;
    (void)sfield__carve_tile(&t, memory, s->occluder_count, t.lights, s->coefs, (uint32_t)t.chains);
    for (i = piece * SFIELD__LANES; i < set->count; i += job->pieces * SFIELD__LANES) {
        t.first = i;
        t.lanes = set->count - i < SFIELD__LANES ? (uint32_t)(set->count - i) : (uint32_t)SFIELD__LANES;
#ifndef SFIELD_WITHOUT_GLOSS
        if (t.chains > 1 && set->cache) t.set_hash = sfield__hash_brdfs(hash, set, i, t.lanes);
#endif
        if (job->incident) sfield__shade_incident(&t, job->incident);
        else sfield__shade_tile(&t);
    }
    *stats = t.stats;
}

static void sfield__shade_task(void *context, size_t piece)
{
    sfield__job *job = (sfield__job *)context;
    uint8_t *memory = job->s->scratch + piece * job->scratch;
    size_t i;
    memory += (64 - ((uintptr_t)memory & 63)) & 63;
    for (i = 0; i < job->set_count; i++)
#ifndef SFIELD_WITHOUT_WAVELETS
        if (!job->s->algebra) sfield__shade_set_haar(job, &job->sets[i], piece, memory, &job->stats[piece]);
        else
#endif
            sfield__shade_set_sh(job, &job->sets[i], piece, memory, &job->stats[piece]);
}

/* Checks pointers, strides and the entity of a set. */
static sfield_result sfield__check_arrays(const sfield__logger *log, const sfield_scene *s,
                                          const sfield_points *p)
{
    if (!sfield__check_value(log, p->count <= 0x7fffffffu, "points->count", (double)p->count, "below 2^31"))
        return SFIELD_ERR_LIMIT;
    if (!sfield__points_good(log, p) ||
        !sfield__check_value(
            log, p->to_eye_stride % 4 == 0 && (!p->to_eye || sfield__stride_valid(p->to_eye_stride, 12)),
            "points->to_eye_stride", (double)p->to_eye_stride, "0, or a multiple of 4 of at least 12") ||
        !sfield__check_value(log, p->exponent_stride % 4 == 0, "points->exponent_stride",
                             (double)p->exponent_stride, "a multiple of 4"))
        return SFIELD_ERR_ARGUMENT;
    if (!sfield__check_value(log, p->entity <= s->item_count, "points->entity", p->entity,
                             "0, or 1 for the first entity, ..."))
        return SFIELD_ERR_INPUT;
    return SFIELD_OK;
}

static sfield_result sfield__check_set(const sfield__logger *log, const sfield_scene *s,
                                       const sfield_points *p)
{
    sfield_result result;
    if (p->count == 0) return SFIELD_OK;
    result = sfield__check_arrays(log, s, p);
    if (result != SFIELD_OK) return result;
#ifdef SFIELD_WITHOUT_GLOSS
    if (p->gloss)
        return sfield__fail(log, SFIELD_ERR_MISMATCH, "points->gloss",
                            "is not in this header, joined without gloss");
#else
    result = sfield__count_chains(p) > 1 ? sfield__check_gloss(log, p) : SFIELD_OK;
    if (result != SFIELD_OK) return result;
#endif
    if (p->self && !sfield__field_fits(s, p->self, SFIELD__KIND_SELF))
        return sfield__fail(log, SFIELD_ERR_MISMATCH, "points->self",
                            "is not a self-visibility of the scene's basis and bands");
    if (p->self && !sfield__check_value(log, p->self->h.samples == p->count, "points->self's count",
                                        p->self->h.samples, "points->count"))
        return SFIELD_ERR_MISMATCH;
#ifndef SFIELD_WITHOUT_WAVELETS
    if (s->desc.product == SFIELD_PRODUCT_SPARSE && sfield__find_unmapped(s, p))
        return sfield__fail(log, SFIELD_ERR_MISMATCH, "points->self",
                            "is on a rotated entity, which SFIELD_PRODUCT_SPARSE does not do");
#endif
    if (p->cache && (p->cache->coefs != s->coefs || !p->cache->cells != !!s->algebra))
        return sfield__fail(log, SFIELD_ERR_MISMATCH, "points->cache",
                            "is not of the scene's basis and bands");
    if (p->cache && !sfield__check_value(log, p->cache->points == p->count, "points->cache's count",
                                         (double)p->cache->points, "points->count"))
        return SFIELD_ERR_MISMATCH;
    result = sfield__check_units(log, "points->normals", p->normals, p->normal_stride, p->count);
#ifndef SFIELD_WITHOUT_GLOSS
    if (result == SFIELD_OK && sfield__count_chains(p) > 1)
        result = sfield__check_units(log, "points->to_eye", p->to_eye, p->to_eye_stride, p->count);
#endif
    return result;
}

static sfield_result sfield__shade_all(sfield__job *job, sfield_scene_stats *stats)
{
    sfield_scene *s = job->s;
    const uint64_t *from;
    uint64_t *to;
    uint64_t bytes = 64;
    uint32_t chains = 1;
    size_t i, k;
#ifndef SFIELD_WITHOUT_GLOSS
    for (i = 0; i < job->set_count; i++) {
        const uint32_t own = (uint32_t)sfield__count_chains(&job->sets[i]);
        chains = own > chains ? own : chains;
#ifndef SFIELD_WITHOUT_CACHE
        if (job->sets[i].count && job->sets[i].cache && job->sets[i].cache->chains < own &&
            sfield__lay_cache(job->sets[i].cache, own) != SFIELD_OK)
            return SFIELD_ERR_ALLOC;
#endif
    }
    if (chains == 3 && s->algebra && !s->brdf && sfield__make_brdf(s) != SFIELD_OK) return SFIELD_ERR_ALLOC;
#endif
#ifndef SFIELD_WITHOUT_WAVELETS
    if (!s->algebra) bytes += sfield__scratch_haar(s, chains > 1 ? 3 : 0);
    else
#endif
        bytes += sfield__carve_tile(NULL, NULL, s->occluder_count, s->light_count, s->coefs, chains);
    job->pieces = s->desc.system.parallel_for ? (uint32_t)SFIELD__PIECES : 1u;
    if (bytes > SIZE_MAX / job->pieces) return SFIELD_ERR_ALLOC;
    job->scratch = (size_t)bytes;
    if (job->scratch * job->pieces > s->scratch_bytes) {
        uint8_t *grown = (uint8_t *)sfield__alloc(&s->allocator, job->scratch * job->pieces);
        if (!grown) return SFIELD_ERR_ALLOC;
        sfield__free(&s->allocator, s->scratch);
        s->scratch = grown;
        s->scratch_bytes = job->scratch * job->pieces;
    }
    memset(job->stats, 0, sizeof job->stats);
    if (s->desc.system.parallel_for)
        s->desc.system.parallel_for(s->desc.system.user, job->pieces, sfield__shade_task, job);
    else sfield__shade_task(job, 0);
    if (!stats) return SFIELD_OK;
    memset(stats, 0, sizeof *stats);
    to = &stats->points;
    for (i = 0; i < job->pieces; i++)           /* eight counters of 64 bits, then the overlaps */
        for (k = 0, from = &job->stats[i].points; k < 8; k++) to[k] += from[k];
    stats->overlaps = s->overlaps;
#ifndef SFIELD_WITHOUT_ROOMS
    stats->rooms = s->held_count;
#endif
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_shade(sfield_scene *scene, const sfield_points *sets, size_t set_count,
                                      sfield_scene_stats *stats)
{
    sfield__job job;
    size_t i;
    sfield__logger log;
    if (!scene) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&scene->desc.system, "sfield_shade");
    if (!sets && set_count) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "sets", "is NULL");
    for (i = 0; i < set_count; i++) {
        sfield_result result = sfield__check_set(&log, scene, &sets[i]);
        if (result != SFIELD_OK) return result;
    }
#ifndef SFIELD_WITHOUT_WAVELETS
    if (sfield__map_receivers(scene, sets, set_count) != SFIELD_OK) return SFIELD_ERR_ALLOC;
#endif
    job.s = scene;
    job.sets = sets;
    job.set_count = set_count;
    job.incident = NULL;
    return sfield__shade_all(&job, stats);
}

SFIELD_DEF sfield_result sfield_incident(sfield_scene *scene, const sfield_points *set, float *coefs)
{
    sfield__job job;
    sfield_result result;
    sfield__logger log;
    if (!scene) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&scene->desc.system, "sfield_incident");
    if (!set || !coefs) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, set ? "coefs" : "set", "is NULL");
    result = sfield__check_set(&log, scene, set);
    if (result != SFIELD_OK) return result;
    if (!scene->algebra || scene->desc.product == SFIELD_PRODUCT_EXP)
        return sfield__fail(&log, SFIELD_ERR_MISMATCH, "scene", "has no products of harmonics");
    job.s = scene;
    job.sets = set;
    job.set_count = 1;
    job.incident = coefs;
    return sfield__shade_all(&job, NULL);
}
