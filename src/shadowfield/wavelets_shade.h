/* ---- wavelets: shading a set of points ---- */

static void sfield__shade_set_haar(const sfield__job *job, const sfield_points *set, size_t piece,
                                   uint8_t *memory, sfield_scene_stats *stats)
{
    const sfield_scene *s = job->s;
    uint64_t *hash = (uint64_t *)(void *)memory;
    const uint32_t rays = s->occluder_count + s->light_count;
    int bundles = sfield__can_bundle(s, set);
    uint32_t kernels = 0;
    sfield__point p;
    sfield__bundle b;
    size_t i, k;
    memset(&p, 0, sizeof p);
    memset(&b, 0, sizeof b);
    p.chains = 1;
#ifndef SFIELD_WITHOUT_GLOSS
    p.chains = (uint32_t)sfield__count_chains(set);
    if (p.chains > 1) {                         /* each point by itself */
        bundles = 0;
        kernels = SFIELD__KERNELS;
    }
#endif
    p.s = b.s = s;
    p.set = set;
    p.all_hash = p.set_hash = sfield__hash_set(s, set);
    p.stats = *stats;
    memory += ((size_t)s->light_count + 8) / 8 * 64;
    memory += sfield__carve_point(&p, memory, rays, s->cells, kernels);
    (void)sfield__carve_bundle(&b, memory, rays, s->side);
    for (i = piece * SFIELD__LANES; i < set->count; i += job->pieces * SFIELD__LANES) {
        const size_t end = i + SFIELD__LANES < set->count ? i + SFIELD__LANES : set->count;
        if (set->gloss) memset(set->gloss + 3 * i, 0, 3 * (end - i) * sizeof *set->gloss);
        if (set->gloss && set->grazing) memset(set->grazing + 3 * i, 0, 3 * (end - i) * sizeof *set->gloss);
        if (bundles) sfield__shade_bundle(&p, &b, i, (uint32_t)(end - i), hash);
        for (k = i; k < end && !bundles; k++) sfield__shade_point(&p, k, hash);
    }
    *stats = p.stats;
}

/* Counts the bytes of memory that a task of sfield__shade_set_haar needs. */
static uint64_t sfield__scratch_haar(const sfield_scene *s, uint32_t kernels)
{
    const uint32_t rays = s->occluder_count + s->light_count;
    return sfield__carve_point(NULL, NULL, rays, s->cells, kernels) +
           (uint64_t)sfield__carve_bundle(NULL, NULL, rays, s->side) + ((size_t)s->light_count + 8) / 8 * 64;
}

/* Returns the entity of a set if it is rotated and only receives, so has no table for a resampling, and the
   set's self-visibility, in wavelets, needs one; else NULL. */
static sfield__item *sfield__find_unmapped(const sfield_scene *s, const sfield_points *p)
{
    sfield__item *it = !p->entity || !p->count || !p->self || s->algebra ? NULL : &s->item[p->entity - 1];
    return it && !it->identity && !it->map ? it : NULL;
}

/* Makes tables for the entities that sfield__find_unmapped finds, so that other receivers need none. */
static sfield_result sfield__map_receivers(sfield_scene *s, const sfield_points *sets, size_t count)
{
    const size_t cells = s->cells;
    sfield__taps *grown;
    uint32_t more = 0;
    size_t i;
    for (i = 0; i < count; i++) more += sfield__find_unmapped(s, &sets[i]) != NULL;
    if (!more) return SFIELD_OK;
    grown =
        (sfield__taps *)sfield__alloc_array(&s->allocator, ((size_t)s->maps + more) * cells, sizeof *grown);
    if (!grown) return SFIELD_ERR_ALLOC;
    if (s->maps) memcpy(grown, s->taps, s->maps * cells * sizeof *grown);
    sfield__free(&s->allocator, s->taps);
    s->taps = grown;
    for (i = 0; i < count; i++) {
        sfield__item *it = sfield__find_unmapped(s, &sets[i]);
        if (!it) continue;
        sfield__make_taps(s, it->turn, s->taps + s->maps * cells);
        it->map = ++s->maps;
    }
    return SFIELD_OK;
}
