/* ---- shading: which occluders count for which points ---- */

/* Returns 1 if the points of a set lie on an entity that hides, else 0. */
static uint32_t sfield__is_on_occluder(const sfield_scene *s, const sfield_points *set)
{
    return set->entity && s->item[set->entity - 1].e.occlusion ? 1u : 0u;
}

/* Returns whether candidate a lies behind candidate b; equal ones keep the order of the scene. */
static int sfield__is_after(const sfield__tile *t, uint32_t a, uint32_t b)
{
    return t->mean[a] > t->mean[b] || (!(t->mean[a] < t->mean[b]) && t->item[a] > t->item[b]);
}

/* Puts an occluder among the candidates, from near to far by the middle of the tile, if it counts for any
   lane: in reach (section 4.2, third rule) and, but for incident radiance, not below the horizon (first). */
static void sfield__try_candidate(sfield__tile *t, uint32_t item)
{
    const sfield__item *it = &t->s->item[item];
    const float *c = it->center[0], x = c[0] - t->middle[0], y = c[1] - t->middle[1], z = c[2] - t->middle[2];
    const float mean = sqrtf(x * x + y * y + z * z), least = mean - t->extent;
    uint32_t j, near_by, used;
    if (item + 1 == t->set->entity || !(least < it->reach)) return;
    used = sfield__look_at16(t->p, t->n, c, it->reach * it->reach, -it->radius[0],
                             t->d2 + (size_t)t->count * SFIELD__LANES, t->s->simd);
    near_by = used & t->active;
    used = t->all_round ? near_by : near_by & used >> 16;
    t->stats.culled_far -= sfield__popcount(near_by);
    t->stats.culled_horizon += sfield__popcount(near_by & ~used);
    if (!used) return;
    t->farthest[t->count] = mean + t->extent;
    t->widest[t->count] = least > it->inscribed ? it->inscribed / least : 1;
    t->used[t->count] = used;
    t->item[t->count] = item;
    t->mean[t->count] = mean;
    t->state[t->count] = SFIELD__NOT_FETCHED;
    for (j = t->count; j > 0 && sfield__is_after(t, t->order[j - 1], t->count); j--)
        t->order[j] = t->order[j - 1];
    t->order[j] = t->count++;
}

/* Finds the occluders that count for any lane. All are far until they prove to be near. */
static void sfield__find_candidates(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    const uint32_t others = s->occluder_count - sfield__is_on_occluder(s, t->set);
    uint32_t i;
#ifndef SFIELD_WITHOUT_HIERARCHY
    sfield__walk w;
#endif
    t->count = 0;
    sfield__bound_lanes(t);
    t->stats.pairs += (uint64_t)t->lanes * others;
    t->stats.culled_far += (uint64_t)sfield__popcount(t->active) * others;
#ifdef SFIELD_WITHOUT_HIERARCHY
    for (i = 0; i < s->occluder_count; i++) sfield__try_candidate(t, s->occluder[i]);
#else
    sfield__start_walk(&w, s, t->middle, t->extent);
    while ((i = sfield__next_near(&w)) != SFIELD__NONE) sfield__try_candidate(t, i);
#endif
}

/* Computes what is left of each candidate for each lane. */
static void sfield__fade_candidates(sfield__tile *t)
{
    uint32_t i;
    for (i = 0; i < t->count; i++) {
        const size_t at = (size_t)i * SFIELD__LANES;
        const float reach = t->s->item[t->item[i]].reach;
        sfield__fade16(t->d2 + at, t->farthest[i] > 0.75f * reach ? 1 / reach : 0, t->used[i], t->factor + at,
                       t->s->simd);
    }
}

#ifndef SFIELD_WITHOUT_HIERARCHY
/* Returns whether light j lies behind all candidates as each lane sees them, by more than what roundings come
   to. The environment does. */
static int sfield__is_behind(const sfield__tile *t, uint32_t j, float farthest)
{
    const float *m = t->middle, slack = 1e-6f * (fabsf(m[0]) + fabsf(m[1]) + fabsf(m[2])) + 1e-18f;
    const sfield__item *it;
    float d;
    if (j == t->lights) return 1;
    it = &t->s->item[t->s->light[j]];
    d = sfield__v3_length(sfield__v3_sub(sfield__v3_load(it->center[1]), sfield__v3_load(m)));
    return !it->e.occlusion && d < 1e18f && 0.9999f * d > farthest + 2 * (t->extent + slack);
}
#endif

/* Finds, for each light, the lanes for which each occluder counts and is nearer than the light. */
static void sfield__find_masks(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    const int cached = t->set->cache != NULL;
    float light[SFIELD__LANES];
    uint32_t j, i;
#ifndef SFIELD_WITHOUT_HIERARCHY
    float farthest = 0;
    for (i = 0; i < t->count; i++) farthest = t->farthest[i] > farthest ? t->farthest[i] : farthest;
#endif
    t->occluders_hash = t->set_hash;
    for (i = 0; i < t->count && cached; i++) {
        const uint32_t o = t->order[i];
        t->occluders_hash = sfield__hash(t->occluders_hash, s->item[t->item[o]].body);
        t->occluders_hash = sfield__hash(t->occluders_hash, t->used[o]);
    }
    t->occluders_hash |= 1;
    for (j = 0; j < t->lights + (uint32_t)t->sky; j++) {
        uint16_t *mask = t->mask + (size_t)j * (s->occluder_count ? s->occluder_count : 1);
        const uint32_t own = j < t->lights ? s->light[j] : SFIELD__NONE;
#ifdef SFIELD_WITHOUT_HIERARCHY
        const int behind = j == t->lights;
#else
        const int behind = sfield__is_behind(t, j, farthest);
#endif
        uint32_t prefix = 0;
        if (sfield__is_own(t, j)) continue;
        if (!behind) sfield__measure_distances(t->p, s->item[own].center[1], light);
        t->hash[j] = t->set_hash;
        for (i = 0; i < t->count; i++) {
            const uint32_t o = t->order[i], used = t->used[o];
            uint32_t bits = used;
            if (!behind)
                bits = t->item[o] == own
                           ? 0
                           : used & sfield__nearer16(t->d2 + (size_t)o * SFIELD__LANES, light, s->simd);
#ifndef SFIELD_WITHOUT_ROOMS
            if (sfield__is_held(s, j, t->item[o])) bits = sfield__mask_room(t, o);
#endif
            mask[i] = (uint16_t)bits;
            prefix += prefix == i && bits == used;
            if (bits && cached)
                t->hash[j] = sfield__hash(sfield__hash(t->hash[j], s->item[t->item[o]].body), bits);
        }
#ifndef SFIELD_WITHOUT_ROOMS
        if (sfield__is_home(s, t->set, j)) t->hash[j] = sfield__hash(t->hash[j], 1);
#endif
        /* Up to number `prefix` of the order T is that of all lights, and is rounded. */
        t->hash[j] = sfield__hash(t->hash[j], prefix) | 1;
        t->prefix[j] = prefix;
    }
}

/* Returns whether no line from a lane to the middle of a meets the inscribed sphere of b. Such a line is
   nowhere farther from the line of the tile's middle than the lanes are from that middle. */
static int sfield__is_aside(const sfield__tile *t, const sfield__item *a, const sfield__item *b)
{
    const sfield__v3 m = sfield__v3_load(t->middle), v = sfield__v3_sub(sfield__v3_load(a->center[0]), m);
    const sfield__v3 c = sfield__v3_cross(v, sfield__v3_sub(sfield__v3_load(b->center[0]), m));
    const float most = 1.001f * (b->inscribed + t->extent);
    return sfield__v3_dot(c, c) > most * most * sfield__v3_dot(v, v);
}

/* Returns, by the second rule of section 4.2, the lanes of a mask for which the bounding sphere of occluder i
   is inside the cone of a nearer inscribed one. */
static uint32_t sfield__find_hidden(const sfield__tile *t, uint32_t i, uint32_t lanes)
{
    const sfield__item *a = &t->s->item[t->item[i]];
    const float a2 = a->radius[0] * a->radius[0], *near_i = t->d2 + i * SFIELD__LANES;
    uint32_t j, l, k, hidden = 0;
    for (j = 0; j < t->count; j++) {
        const sfield__item *b = &t->s->item[t->item[j]];
        const float b2 = b->inscribed * b->inscribed, *near_j = t->d2 + j * SFIELD__LANES;
        /* Then occluder j hides i from no lane. */
        if (!(t->widest[j] * t->farthest[i] > a->radius[0]) || j == i) continue;
        if (sfield__is_aside(t, a, b)) continue;
        for (l = 0; l < SFIELD__LANES; l++) {
            float d2 = near_i[l], e2 = near_j[l], dot = 0;
            float sines, cosines;
            if (!((lanes & ~hidden) >> l & 1) || e2 >= d2 || a2 >= d2 || b2 >= e2 || b2 * d2 <= a2 * e2)
                continue;
            if (t->factor[j * SFIELD__LANES + l] < 1) continue;
            for (k = 0; k < 3; k++)
                dot += (a->center[0][k] - t->p[16 * k + l]) * (b->center[0][k] - t->p[16 * k + l]);
            sines = a->radius[0] * b->inscribed;
            cosines = sqrtf((d2 - a2) * (e2 - b2));
            if (dot >= cosines + sines) hidden |= 1u << l;
        }
    }
    return hidden;
}
