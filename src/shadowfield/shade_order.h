/* ---- shading: from near to far, and for incident radiance from far to near ---- */

/* Shades 16 points as figure 5 of the paper does: T is multiplied by the visibility of occluders from near to
   far, and each light takes the T of the moment. Occluders commute up to truncation and are ordered for the
   tile; which of them are nearer than a light is decided lane by lane. */
static void sfield__chain_products(sfield__tile *t, sfield_cache *cache)
{
    const sfield_scene *s = t->s;
    const uint32_t n = t->count, slots = t->lights + (uint32_t)t->sky, chains = (uint32_t)t->chains;
    const size_t size = chains * (size_t)s->coefs * SFIELD__LANES, tile = t->first / SFIELD__LANES;
    uint32_t step = n + 1, from = 0, last = 0, least = n;
    uint32_t i, j, a, b;
    float *now = t->start;
    for (j = 0; j < slots; j++) {
        if (!t->needed[j]) continue;
        least = t->prefix[j] < least ? t->prefix[j] : least;
        for (i = n; i-- > last;)
            if (t->mask[(size_t)j * s->occluder_count + i]) last = i + 1;
    }
#ifndef SFIELD_WITHOUT_CACHE
    if (cache) {
        step = s->occluder_count / ((cache->lights < 255 ? cache->lights : 255) + 1) + 1;
        if (cache->lit[tile] != t->occluders_hash) cache->marks[tile] = 0;
        cache->lit[tile] = t->occluders_hash;
        from = least / step < cache->marks[tile] ? least / step : cache->marks[tile];
        if (from) sfield__recall_tile(cache, sfield__mark_slot(cache, tile, from), now, chains, s->simd);
        from *= step;
    }
#else
    (void)cache, (void)tile, (void)step, (void)least, (void)chains;
#endif
    if (!from) sfield__start_tile(t);
    for (i = from; i < last; i++) sfield__fetch_occluder(t, t->order[i]);
    for (i = from; i <= last; i++) {
#ifndef SFIELD_WITHOUT_CACHE
        /* T is rounded even if nothing starts here, so that a later start from here is the same. */
        if (i > from && i % step == 0) {
            const size_t slot = sfield__mark_slot(cache, tile, i / step);
            sfield__keep_tile(cache, slot, now, chains);
            sfield__recall_tile(cache, slot, now, chains, s->simd);
            if (cache->marks[tile] < i / step) cache->marks[tile] = (uint8_t)(i / step);
        }
#endif
        for (j = 0; j < slots; j++) {
            const uint16_t *mask = t->mask + (size_t)j * s->occluder_count;
            float *light = t->t + j * size;
            if (!t->needed[j]) continue;
            a = t->prefix[j] < last ? t->prefix[j] : last;
            if (a != i) continue;
            for (b = last; b > a && !mask[b - 1]; b--) { }
#ifndef SFIELD_WITHOUT_ROOMS
            if (sfield__is_home(s, t->set, j)) {
                sfield__chain_at_home(t, mask, b, light);
                continue;
            }
#endif
            memcpy(light, now, size * sizeof *light);
            for (; a < b; a++) sfield__apply_occluder(t, t->order[a], mask[a], light);
        }
        if (i < last) sfield__apply_occluder(t, t->order[i], t->used[t->order[i]], now);
    }
}

/* Shades 16 points by logarithms: for each light they are added up, which costs one exponential and one
   product. */
static void sfield__chain_logarithms(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    uint32_t n = s->coefs * SFIELD__LANES, slots = t->lights + (uint32_t)t->sky, i;
    uint32_t j, k, l;
    size_t size = (size_t)t->chains * n;
    float *sum = t->turned;
    int c;
    sfield__start_tile(t);
    for (i = 0; i < t->count; i++) sfield__fetch_occluder(t, t->order[i]);
    for (j = 0; j < slots; j++) {
        if (!t->needed[j]) continue;
        memset(sum, 0, n * sizeof *sum);
        for (i = 0; i < t->count; i++) {
            uint32_t mask = t->mask[(size_t)j * s->occluder_count + i];
            const float *o = t->occlusion + (size_t)t->order[i] * n;
            if (t->state[t->order[i]] == SFIELD__ALL_HIDDEN || !mask) continue;
            for (k = 0; k < n; k += SFIELD__LANES)
                for (l = 0; l < SFIELD__LANES; l++) sum[k + l] += mask >> l & 1 ? o[k + l] : 0.0f;
        }
        sfield__exponentiate16(s->algebra, sum, sum);
        t->stats.products += sfield__popcount(t->active);
        for (c = 0; c < t->chains; c++)
            sfield__product16(s->algebra, t->start + (size_t)c * n, sum, t->t + j * size + (size_t)c * n,
                              SFIELD__LANES, 0);
    }
}

/* Writes the results of the last frame again if nothing touched the tile since. Returns 1 if it did so. */
static int sfield__repeat_tile(sfield__tile *t, uint32_t in_view)
{
    const size_t unit = t->first / SFIELD__LANES;
    uint64_t points, lights;
    if (!sfield__is_untouched(t->s, t->set, t->set_hash, unit, in_view)) return 0;
    points = sfield__repeat_results(t->set, unit, t->first, t->lanes, in_view);
    lights = points * sfield__lights_of(t->s, t->set, t->sky);
    t->stats.points += points;
    t->stats.lights += lights;
    t->stats.reused += lights;
    return 1;
}

/* Keeps the results that were written, for the next frame. */
static void sfield__keep_tile_results(const sfield__tile *t, uint32_t in_view)
{
    sfield__last now;
    memset(&now, 0, sizeof now);
    now.seen = sfield__hash(t->set_hash, t->s->now_hash);
    memcpy(now.middle, t->middle, sizeof now.middle);
    now.extent = t->extent;
    now.in_view = in_view;
    now.active = t->active;
    sfield__keep_results(t->set, t->first / SFIELD__LANES, t->first, t->lanes, &now);
}

#ifndef SFIELD_WITHOUT_CACHE
/* Asks for the memory in which a cache keeps T of the tile. The memory arrives while occluders are looked
   through. */
static void sfield__fetch_kept(const sfield__tile *t, const sfield_cache *cache)
{
    const size_t values = (size_t)cache->lights * cache->chains * t->s->coefs;
    const char *kept = (const char *)(cache->value + t->first * values);
    const size_t bytes = 2 * SFIELD__LANES * values;
    size_t i;
    for (i = 0; i < bytes && i < 8192; i += 64) SFIELD__PREFETCH(kept + i);
}

/* Keeps T of those lights for which it was computed, and takes T of all lights from the cache: new ones too,
   so that they are rounded like those that were kept. */
static void sfield__exchange_kept(sfield__tile *t, sfield_cache *cache, uint32_t slots)
{
    const uint32_t chains = (uint32_t)t->chains;
    const size_t size = chains * (size_t)t->s->coefs * SFIELD__LANES;
    uint32_t j;
    for (j = 0; j < slots && j < cache->lights; j++) {
        const size_t slot = t->first / SFIELD__LANES * cache->lights + j;
        if (sfield__is_own(t, j)) continue;
        if (t->needed[j]) {
            sfield__keep_tile(cache, slot, t->t + j * size, chains);
            cache->hash[slot] = t->hash[j];
        }
        sfield__recall_tile(cache, slot, t->t + j * size, chains, t->s->simd);
    }
}
#endif

/* Finds the lights whose T has to be computed: no cache keeps it, or an old one. Returns how many. */
static uint32_t sfield__find_needed(sfield__tile *t, const sfield_cache *cache, uint32_t slots)
{
    uint32_t j, needed = 0;
    for (j = 0; j < slots; j++) {
        const size_t slot = t->first / SFIELD__LANES * (cache ? cache->lights : 0) + j;
        t->needed[j] = 0;
        if (sfield__is_own(t, j)) continue;
        t->needed[j] = !cache || j >= cache->lights || cache->hash[slot] != t->hash[j];
        needed += t->needed[j];
        if (!t->needed[j]) t->stats.reused += sfield__popcount(t->in_view);
    }
    return needed;
}

/* Shades sixteen points and writes their results. */
static void sfield__shade_tile(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    const uint32_t slots = t->lights + (uint32_t)t->sky;
    const size_t size = (size_t)t->chains * s->coefs * SFIELD__LANES;
    sfield_cache *cache = t->set->cache;
#ifndef SFIELD_WITHOUT_CACHE
    const uint32_t in_view = cache ? sfield__bits_in_view(t->set, t->first, t->lanes) : 0;
    if (cache && sfield__repeat_tile(t, in_view)) return;
#endif
    sfield__load_lanes(t);
    if (!t->in_view) {
        memset(t->t, 0, (size_t)(t->lights + 1) * size * sizeof *t->t);
        sfield__write_outputs(t);
        return;
    }
#ifndef SFIELD_WITHOUT_CACHE
    if (cache) sfield__fetch_kept(t, cache);
#endif
    t->stats.points += sfield__popcount(t->in_view);
    t->stats.lights += (uint64_t)sfield__popcount(t->in_view) * sfield__lights_of(s, t->set, t->sky);
    sfield__find_candidates(t);
    sfield__find_masks(t);
    if (sfield__find_needed(t, cache, slots)) {
        sfield__fade_candidates(t);
#ifndef SFIELD_WITHOUT_LOGARITHMS
        if (s->desc.product == SFIELD_PRODUCT_EXP) sfield__chain_logarithms(t);
        else
#endif
        sfield__chain_products(t, cache);
    }
#ifndef SFIELD_WITHOUT_CACHE
    if (cache) sfield__exchange_kept(t, cache, slots);
#endif
    sfield__write_outputs(t);
#ifndef SFIELD_WITHOUT_CACHE
    if (cache) sfield__keep_tile_results(t, in_view);
#endif
}

/* Returns whether the order leaves light j out: it is the points' own, or lies in a room. */
static int sfield__is_alone(const sfield__tile *t, uint32_t j)
{
#ifndef SFIELD_WITHOUT_ROOMS
    uint32_t i;
    for (i = 0; i < t->s->held_count; i++)
        if (t->s->held[i].light == j) return 1;
#endif
    return sfield__is_own(t, j);
}

/* Returns the lanes for which light j lies just before occluder i - 1 of the order; i = 0: before all. */
static uint32_t sfield__find_lanes_behind(const sfield__tile *t, uint32_t j, uint32_t i)
{
    const uint16_t *mask = t->mask + (size_t)j * t->s->occluder_count;
    uint32_t lanes = 0, l, k;
    for (l = 0; l < SFIELD__LANES; l++) {
        for (k = t->count; k > 0 && !(mask[k - 1] >> l & 1); k--) { }
        lanes |= (uint32_t)(k == i) << l;
    }
    return lanes;
}

/* Adds the radiance of light j to sum, for some lanes, three channels of planes. */
static void sfield__add_radiance(const sfield__tile *t, uint32_t j, uint32_t lanes, float *sum)
{
    const sfield_scene *s = t->s;
    const sfield__item *it = &s->item[s->light[j]];
    const sfield_field *f = it->e.source;
    const uint32_t n = s->coefs * SFIELD__LANES;
    float *planes = t->planes, *rows = t->rows, local[48];
    uint32_t c, k, l;
    sfield__place at;
    sfield__move_to_local(it, 1, t->p, local, s->simd);
    sfield__locate16(f, local, &at, s->simd);
    for (l = 0; l < SFIELD__LANES; l++)
        sfield__fetch_lane(f, &at, (int)l, it->e.time, f->h.stride, rows + l * f->h.stride, s->simd);
    for (c = 0; c < 3; c++) {
        for (k = 0; k < n; k++) {
            l = k % SFIELD__LANES;
            planes[k] = lanes >> l & 1
                            ? it->e.tint[c] * rows[l * f->h.stride + c * s->planes + k / SFIELD__LANES]
                            : 0.0f;
        }
        if (!it->identity)
            sfield__rotate16(&s->rotation[s->light[j]], planes, planes, SFIELD__LANES, 0, s->simd);
        for (k = 0; k < n; k++) sum[c * n + k] += planes[k];
    }
}

#ifndef SFIELD_WITHOUT_ROOMS
/* Adds the radiance of light j, which lies in a room. From inside no wall hides it and from outside all do,
   so that it has no one place in the order: what hides it is taken by itself. */
static void sfield__add_tenant(sfield__tile *t, uint32_t j, float *sum)
{
    const sfield_scene *s = t->s;
    const uint32_t n = s->coefs * SFIELD__LANES;
    const uint16_t *mask = t->mask + (size_t)j * s->occluder_count;
    float *own = sum + 3 * n;
    uint32_t i, k, c;
    memset(own, 0, 3 * n * sizeof *own);
    sfield__add_radiance(t, j, t->active, own);
    for (i = t->count; i-- > 0;) {
        const uint32_t o = t->order[i];
        const float *occlusion = t->occlusion + (size_t)o * n;
        if (!mask[i] || t->state[o] == SFIELD__ALL_HIDDEN) continue;
        if (mask[i] != t->used[o]) {
            sfield__select16(occlusion, n, mask[i], t->turned, s->simd);
            occlusion = t->turned;
        }
        t->stats.products += 3 * sfield__popcount(mask[i]);
        for (c = 0; c < 3; c++)
            sfield__product16(s->algebra, own + c * n, occlusion, own + c * n, SFIELD__LANES, 1);
    }
    for (k = 0; k < 3 * n; k++) sum[k] += own[k];
}
#endif

/* Computes the radiance that arrives at 16 points, three channels, from far to near (section 3.2 of the
   paper). Each occluder hides part of the radiance so far, and each light joins it. Lanes may disagree about
   the order of a light and an occluder, so the order is made lane by lane. */
static void sfield__shade_incident(sfield__tile *t, float *out)
{
    const sfield_scene *s = t->s;
    const uint32_t n = s->coefs * SFIELD__LANES;
    float *sum = t->t;
    uint32_t i, j, k;
    uint32_t l, c;
    sfield__load_lanes(t);
    sfield__find_candidates(t);
    sfield__find_masks(t);
    sfield__fade_candidates(t);
    for (i = 0; i < t->count; i++) sfield__fetch_occluder(t, t->order[i]);
    for (c = 0; c < 3; c++)
        for (k = 0; k < n; k++)
            sum[c * n + k] = s->has_sky || s->has_sun ? s->sky_now[c * s->planes + k / SFIELD__LANES] : 0.0f;
    for (i = t->count + 1; i-- > 0;) {
        for (j = 0; j < t->lights; j++) {
            const uint32_t lanes = sfield__is_alone(t, j) ? 0 : sfield__find_lanes_behind(t, j, i);
            if (lanes & t->active) sfield__add_radiance(t, j, lanes, sum);
        }
        if (i == 0 || t->state[t->order[i - 1]] == SFIELD__ALL_HIDDEN) continue;
        t->stats.products += 3 * sfield__popcount(t->active);
        for (c = 0; c < 3; c++)
            sfield__product16(s->algebra, sum + c * n, t->occlusion + (size_t)t->order[i - 1] * n,
                              sum + c * n, SFIELD__LANES, 1);
    }
#ifndef SFIELD_WITHOUT_ROOMS
    for (j = 0; j < t->lights; j++)
        if (!sfield__is_own(t, j) && sfield__is_alone(t, j)) sfield__add_tenant(t, j, sum);
#endif
    for (l = 0; l < t->lanes; l++)
        for (k = 0; k < 3 * s->coefs; k++)
            out[(t->first + l) * 3 * s->coefs + k] =
                t->in_view >> l & 1 ? sum[k * SFIELD__LANES + l] : 0.0f;
}

typedef struct sfield__job {
    sfield_scene        *s;
    const sfield_points *sets;
    size_t               set_count;
    size_t               scratch;               /* bytes a task */
    uint32_t             pieces;
    float               *incident;
    sfield_scene_stats   stats[SFIELD__PIECES];
} sfield__job;
