/* ---- wavelets: one point, from near to far ---- */

static void sfield__find_lists_of(const sfield__item *it, int which, const float *x, float time, int simd,
                             sfield__lists *lists)
{
    const sfield_field *f = which ? it->e.source : it->e.occlusion;
    float p[48] = { 0 }, local[48];
    sfield__place at;
    uint32_t k;
    for (k = 0; k < 3; k++) p[16 * k] = x[k];
    sfield__move_to_local(it, which, p, local, simd);
    sfield__locate16(f, local, &at, simd);
    sfield__find_lists(f, &at, 0, time, lists);
}

/* Puts an occluder in reach and above the horizon, or a light, among the `count` entities of a point, from
   near to far; equally far ones in the order of the scene, a light before the occluder that it also is.
   Returns how many there are. */
static uint32_t sfield__add_ray(sfield__point *p, const float *x, const float *n, uint32_t item, int light,
                                uint32_t count)
{
    const sfield__item *it = &p->s->item[item];
    const float *c = it->center[light >= 0];
    sfield__ray *r = p->ray, *to = r + count;
    float d[3], d2;
    if (item + 1 == p->set->entity) return count;           /* neither hides nor lights its own points */
    d[0] = c[0] - x[0];
    d[1] = c[1] - x[1];
    d[2] = c[2] - x[2];
    d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    if (light < 0) {
        if (!(d2 < it->reach * it->reach)) return count;
        p->stats.culled_far--;
        if (d[0] * n[0] + d[1] * n[1] + d[2] * n[2] <= -it->radius[0]) {
            p->stats.culled_horizon++;
            return count;
        }
    }
    for (; to > r && (to[-1].d2 > d2 || (!(to[-1].d2 < d2) && to[-1].item > item)); to--) *to = to[-1];
    to->d2 = d2;
    to->item = item;
    to->light = light;
    return count + 1;
}

/* Lists the entities of a point, occluders and lights, from near to far. Returns how many there are. */
static uint32_t sfield__find_rays(sfield__point *p, const float *x, const float *n)
{
    const sfield_scene *s = p->s;
    const uint32_t others = s->occluder_count - sfield__is_on_occluder(s, p->set);
    uint32_t i, count = 0;
#ifndef SFIELD_WITHOUT_HIERARCHY
    sfield__walk w;
#endif
    p->stats.pairs += others;
    p->stats.culled_far += others;
    for (i = 0; i < s->light_count; i++) count = sfield__add_ray(p, x, n, s->light[i], (int)i, count);
#ifdef SFIELD_WITHOUT_HIERARCHY
    for (i = 0; i < s->occluder_count; i++) count = sfield__add_ray(p, x, n, s->occluder[i], -1, count);
#else
    sfield__start_walk(&w, s, x, 0);
    while ((i = sfield__next_near(&w)) != SFIELD__NONE) count = sfield__add_ray(p, x, n, i, -1, count);
#endif
#ifndef SFIELD_WITHOUT_ROOMS
    if (s->held_count) sfield__order_rooms(p, x, count);
#endif
    return count;
}

/* Returns whether ray i is hidden by the second rule of culling, as tiles have it: rays [0, i) are nearer. */
static int sfield__is_hidden(const sfield__point *p, uint32_t i, const float *x)
{
    const sfield__item *a = &p->s->item[p->ray[i].item];
    const int which = p->ray[i].light >= 0;
    float d2 = p->ray[i].d2, sin_a = a->radius[which] / sqrtf(d2), cos_a;
    uint32_t j, k;
    if (!(sin_a < 1)) return 0;
    cos_a = sqrtf(1 - sin_a * sin_a);
    for (j = 0; j < i; j++) {
        const sfield__item *b = &p->s->item[p->ray[j].item];
        float e2 = p->ray[j].d2, sin_b, dot = 0;
        if (p->ray[j].light >= 0 || !(b->inscribed > 0) || b->inscribed * b->inscribed >= e2 || b == a)
            continue;
        if (e2 > 0.5625f * b->reach * b->reach) continue;
        sin_b = b->inscribed / sqrtf(e2);
        if (sin_b <= sin_a) continue;
        for (k = 0; k < 3; k++) dot += (a->center[which][k] - x[k]) * (b->center[0][k] - x[k]);
        if (dot >= (cos_a * sqrtf(1 - sin_b * sin_b) + sin_a * sin_b) * sqrtf(d2 * e2)) return 1;
    }
    return 0;
}

/* Computes T = BRDF x max(0, cos) x solid angle x visibility of the own object, on texels. */
static void sfield__start_texels(sfield__point *p, size_t index, const float *n)
{
    const sfield_scene *s = p->s;
#ifndef SFIELD_WITHOUT_GLOSS
    if (p->kernel) memcpy(p->t, p->kernel, s->cells * sizeof *p->t);
    else
#endif
        sfield__fill_cosines16(s->texel, s->cells, n, p->t, s->simd);
    if (p->set->self) {
        sfield__lists own;
        const int sparse = s->desc.product == SFIELD_PRODUCT_SPARSE;
        uint32_t map = p->set->entity ? s->item[p->set->entity - 1].map : 0;
        own.count = 1;
        own.sample[0] = index;
        own.weight[0] = 1;
        if (sparse) sfield__haar_cube(s->side, p->t, p->haar, s->simd);
        sfield__add_lists(p, p->set->self, &own, 1);
        sfield__hide_texels(p, map);
        sfield__clear_lists(p);
    } else if (s->desc.product == SFIELD_PRODUCT_SPARSE) sfield__haar_cube(s->side, p->t, p->haar, s->simd);
}

/* Adds what a light's lists make of T in wavelets (of rotated lights: of T on texels). */
static void sfield__add_light(sfield__point *p, const sfield__item *it, const float *x, const float *haar)
{
    const sfield_scene *s = p->s;
    const sfield_field *f = it->e.source;
    const uint32_t cells = s->cells;
    sfield__lists lists;
    float rgb[3] = { 0, 0, 0 };
    uint32_t i, k, c;
    sfield__find_lists_of(it, 1, x, it->e.time, s->simd, &lists);
    if (!it->map) {
        for (i = 0; i < lists.count; i++) {
            float w = lists.weight[i] * f->sample_scale[lists.sample[i]];
            for (k = f->offset[lists.sample[i]]; k < f->offset[lists.sample[i] + 1]; k++) {
                const uint32_t *e = f->entry + 2 * (size_t)k;
                float t = w * haar[e[0] >> 16];
                rgb[0] += t * sfield__signed_short(e[0]);
                rgb[1] += t * sfield__signed_short(e[1] >> 16);
                rgb[2] += t * sfield__signed_short(e[1]);
            }
        }
    } else {
        const sfield__taps *taps = s->taps + (size_t)(it->map - 1) * cells;
        for (i = 0; i < lists.count; i++) sfield__scatter_list(f, lists.sample[i], lists.weight[i], p->coefs);
        for (c = 0; c < 3; c++) {
            sfield__haar_texels(s->side, p->coefs + c * cells, p->work);
            for (i = 0; i < cells; i++)
                for (k = 0; k < 4 && p->t[i] != 0; k++)
                    rgb[c] += p->t[i] * taps[i].weight[k] * p->work[taps[i].texel[k]];
        }
        memset(p->coefs, 0, 3 * (size_t)cells * sizeof *p->coefs);
    }
    for (c = 0; c < 3; c++) p->rgb[c] += it->e.tint[c] * rgb[c];
}

/* Keeps the largest wavelets of T in the cache, by the measure that fields are cut with. */
static void sfield__keep_wavelets(sfield__point *p, sfield_cache *c, size_t slot)
{
    const uint32_t cells = p->s->cells, side = p->s->side;
    uint16_t *index = c->index + slot * SFIELD__CACHED;
    int16_t *value = c->value + slot * SFIELD__CACHED;
    float threshold = 0, most = 0, inverse, weight = 0;
    uint32_t i, n = 0, used = 0, equal = SFIELD__CACHED;
    uint32_t next = 0, face = side * side;
    float *key = p->work, *sorted = p->coefs;   /* clean again below */
    for (i = 0; i < cells; i++) {
        uint32_t in_face = i & (face - 1);
        if (in_face == 0 || in_face == next) {      /* the next finer level */
            weight = in_face ? 0.5f * weight : (float)side;
            next = in_face ? 4 * next : 4;
        }
        key[i] = fabsf(p->haar[i]) * weight;
        if (key[i] > 0) sorted[used++] = key[i];
    }
    if (used > SFIELD__CACHED) threshold = sfield__select_rank(sorted, used, SFIELD__CACHED - 1);
    memset(sorted, 0, used * sizeof *sorted);
    /* those that lie at the threshold have the places that are left: mirrored lobes have many of one size */
    for (i = 0; i < cells; i++) equal -= key[i] > threshold;
    for (i = 0; i < cells; i++)
        if (key[i] > 0 && (key[i] > threshold || (key[i] == threshold && equal && equal--))) {
            index[n++] = (uint16_t)i;
            most = fabsf(p->haar[i]) > most ? fabsf(p->haar[i]) : most;
        }
    c->scale[slot] = sfield__scale_of(most);
    inverse = most > SFIELD__LEAST_T ? 32767 / most : 0;
    for (i = 0; i < SFIELD__CACHED; i++) {
        value[i] = i < n ? sfield__to_int16(p->haar[index[i]] * inverse) : (int16_t)0;
        if (i >= n) index[i] = 0;
    }
}

/* Adds light from the cache: a few wavelets of T times the sky's, once for each T and sky, or unpacked for
   the lists of lights. */
static void sfield__light_from_cache(sfield__point *p, const sfield_cache *c, size_t slot,
                                     const sfield__item *it, const float *x)
{
    const uint16_t *index = c->index + slot * SFIELD__CACHED;
    const int16_t *value = c->value + slot * SFIELD__CACHED;
    const uint32_t cells = p->s->cells;
    uint32_t i, k;
    if (!it) {
        const size_t own = slot / c->chains / c->lights * c->chains + p->chain;
        const uint64_t now = sfield__hash(c->hash[slot], p->s->sky_hash) | 1;
        uint64_t *lit = &c->lit[own];
        float *rgb = c->sky + 3 * own;
        for (k = 0; k < 3 && *lit != now; k++) {
            const float *sky = p->s->sky_now + (3 + k) * cells;
            rgb[k] = 0;
            for (i = 0; i < SFIELD__CACHED; i++) rgb[k] += (float)value[i] * sky[index[i]];
            rgb[k] *= c->scale[slot];
        }
        *lit = now;
        for (k = 0; k < 3; k++) p->rgb[k] += rgb[k];
        return;
    }
    if (it->map) {
        memset(p->haar, 0, cells * sizeof *p->haar);
        for (i = 0; i < SFIELD__CACHED; i++) p->haar[index[i]] += (float)value[i] * c->scale[slot];
        sfield__haar_texels(p->s->side, p->haar, p->t);
        sfield__add_light(p, it, x, NULL);
        return;
    }
    for (i = 0; i < SFIELD__CACHED; i++) p->coefs[index[i]] += (float)value[i] * c->scale[slot];
    sfield__add_light(p, it, x, p->coefs);
    for (i = 0; i < SFIELD__CACHED; i++) p->coefs[index[i]] = 0;
}

static void sfield__add_sky(sfield__point *p)
{
    const sfield_scene *s = p->s;
    const int sparse = s->desc.product == SFIELD_PRODUCT_SPARSE;
    const float *sky = s->sky_now + (sparse ? 3u : 0u) * s->cells, *t = sparse ? p->haar : p->t;
    float sum[32];
    uint32_t c, k;
    sfield__dot_sky16(sky, t, s->cells, sum, s->simd);
    for (c = 0; c < 3; c++)
        for (k = 0; k < 8; k++) p->rgb[c] += sum[8 * c + k];
}

/* Returns whether a cache keeps T for a light. */
static int sfield__keeps_light(const sfield_cache *c, uint32_t slot) { return c && slot < c->lights; }

/* Returns where a cache keeps the T of the moment for a light of point `index`. */
static size_t sfield__slot_of(const sfield__point *p, size_t index, uint32_t light)
{
    const sfield_cache *c = p->set->cache;
    return (index * c->lights + light) * c->chains + p->chain;
}

/* Goes through the first rays of figure 5 on texels (or on coefficients). Lights that a cache keeps T for are
   not added here, but later from what was kept; only those whose T is out of date are kept anew. */
static void sfield__walk_rays(sfield__point *p, size_t index, const float *x, const float *n, uint32_t count,
                              const uint64_t *hash, uint32_t until, float *ambient)
{
    const sfield_scene *s = p->s;
    sfield_cache *cache = p->set->cache;
    const int sparse = s->desc.product == SFIELD_PRODUCT_SPARSE;
    uint32_t i, k;
    int fresh = 0;                              /* p->haar is that of p->t */
    sfield__start_texels(p, index, n);
    for (i = 0; i < until; i++) {
        const sfield__item *it = i < count ? &s->item[p->ray[i].item] : NULL;
        const uint32_t slot = it ? (uint32_t)p->ray[i].light : s->light_count;
        uint64_t *kept;
        if (it && p->ray[i].light < 0) {
            sfield__lists lists;
            float fade = 4 * (1 - sqrtf(p->ray[i].d2) / it->reach);
            if (sfield__is_hidden(p, i, x)) {
                p->stats.culled_hidden++;
                continue;
            }
            sfield__find_lists_of(it, 0, x, 0, s->simd, &lists);
            sfield__add_lists(p, it->e.occlusion, &lists, fade < 1 ? fade : 1);
            sfield__hide_texels(p, it->map);
            sfield__clear_lists(p);
            p->stats.products++;
            fresh = 0;
            continue;
        }
#ifndef SFIELD_WITHOUT_ROOMS
        if (sfield__is_home(s, p->own, slot) != p->home) continue;
#endif
        kept = sfield__keeps_light(cache, slot) ? &cache->hash[sfield__slot_of(p, index, slot)] : NULL;
        if (kept && *kept == hash[slot]) continue;
        if (!fresh && !sparse && (kept || (it && !it->map))) {
            sfield__haar_cube(s->side, p->t, p->haar, s->simd);
            fresh = 1;
        }
        if (kept) {
            sfield__keep_wavelets(p, cache, sfield__slot_of(p, index, slot));
            *kept = hash[slot];
        } else if (it) sfield__add_light(p, it, x, p->haar);
        else if (s->has_sky || s->has_sun) sfield__add_sky(p);
    }
    if (ambient) {
        float sum = 0;
        if (sparse) sfield__haar_texels(s->side, p->haar, p->t);
        for (k = 0; k < s->cells; k++) sum += p->t[k];
        *ambient = sum * 0.318309886f;
    }
}

/* Writes the hash of all that T of each light depends on, which is the occluders nearer than the light; 0 for
   lights that are not asked for. Returns how many rays have to be walked, the environment as the last: up to
   the last light whose T is not kept, or is out of date. */
static uint32_t sfield__find_stale(sfield__point *p, size_t index, uint32_t count, uint64_t *hash)
{
    const sfield_scene *s = p->s;
    const sfield_cache *cache = p->set->cache;
    const int sky = s->has_sky || s->has_sun;
    uint64_t before = p->set_hash;
    uint32_t i, until = 0;
    for (i = 0; i <= s->light_count; i++) hash[i] = 0;
    for (i = 0; i <= count; i++) {
        const uint32_t slot = i < count ? (uint32_t)p->ray[i].light : s->light_count;
        if (i < count && p->ray[i].light < 0) {
            before = sfield__hash(before, s->item[p->ray[i].item].body);
            continue;
        }
        if (i == count && !sky && !p->set->ambient) continue;
#ifndef SFIELD_WITHOUT_ROOMS
        hash[slot] = (sfield__is_home(s, p->set, slot) ? sfield__hash(before, 1) : before) | 1;
#else
        hash[slot] = before | 1;
#endif
        if (sfield__keeps_light(cache, slot) && cache->hash[sfield__slot_of(p, index, slot)] == hash[slot])
            p->stats.reused += i < count || sky;
        else
            until = i + 1;
    }
    return until;
}

/* Returns the light of a sky of 1 by the T that is kept for the environment: sums of whole faces. */
static float sfield__ambient_from_cache(const sfield_scene *s, const sfield_cache *c, size_t slot)
{
    float sum = 0;
    size_t i, at = slot * SFIELD__CACHED;
    for (i = at; i < at + SFIELD__CACHED; i++)
        if (c->index[i] % (s->side * s->side) == 0)
            sum += (float)c->value[i] * c->scale[slot] * (float)s->side * 0.318309886f;
    return sum;
}

/* Computes light by the T of the moment, once rays and what is stale are known: writes p->rgb, and *ambient
   if the caller asks for it. */
static void sfield__light_chain(sfield__point *p, size_t index, const float *x, const float *n,
                                uint32_t count, uint32_t until, const uint64_t *hash, float *ambient)
{
    const sfield_scene *s = p->s;
    sfield_cache *cache = p->set->cache;
    const int kept = sfield__keeps_light(cache, s->light_count);
    uint32_t j;
#ifndef SFIELD_WITHOUT_ROOMS
    p->own = p->set;
    if (until && sfield__has_home(s, p->set)) {     /* lights of the room, without its self-visibility */
        sfield_points bare = *p->own;
        bare.self = NULL;
        p->set = &bare;
        p->home = 1;
        sfield__walk_rays(p, index, x, n, count, hash, until, NULL);
        p->set = p->own;
        p->home = 0;
    }
#endif
    if (until) sfield__walk_rays(p, index, x, n, count, hash, until, kept ? NULL : ambient);
    for (j = 0; cache && j <= s->light_count && j < cache->lights; j++)
        if (!hash[j]) continue;                 /* the own entity's */
        else if (j < s->light_count)
            sfield__light_from_cache(p, cache, sfield__slot_of(p, index, j), &s->item[s->light[j]], x);
        else if (s->has_sky || s->has_sun)
            sfield__light_from_cache(p, cache, sfield__slot_of(p, index, j), NULL, x);
    if (ambient && kept)
        *ambient = sfield__ambient_from_cache(s, cache, sfield__slot_of(p, index, s->light_count));
}

/* Shades a point that can be shaded: writes p->rgb, and *ambient if the caller asks for it. */
static void sfield__light_point(sfield__point *p, size_t index, const float *x, const float *n,
                                uint64_t *hash, float *ambient)
{
    const uint32_t count = sfield__find_rays(p, x, n), until = sfield__find_stale(p, index, count, hash);
    sfield__light_chain(p, index, x, n, count, until, hash, ambient);
}

#ifndef SFIELD_WITHOUT_GLOSS
static SFIELD__COLD void sfield__light_gloss(sfield__point *p, const sfield__tile *one, uint64_t *hash,
                                             float *ambient);
#endif

static void sfield__shade_point(sfield__point *p, size_t index, uint64_t *hash)
{
    const sfield_scene *s = p->s;
    const sfield_points *set = p->set;
    const uint32_t lights = sfield__lights_of(s, set, s->has_sky || s->has_sun);
    sfield__tile one;                           /* a tile of one lane, since tiles load points */
    float x[3], n[3], ambient = 0, rgb[3] = { 0, 0, 0 };
    uint32_t k, in_view = sfield__bits_in_view(set, index, 1);
#ifndef SFIELD_WITHOUT_GLOSS
    if (p->chains > 1 && set->cache) p->set_hash = sfield__hash_brdfs(p->all_hash, set, index, 1);
#endif
    if (set->cache && sfield__is_untouched(s, set, p->set_hash, index, in_view)) {
        const uint32_t points = sfield__repeat_results(set, index, index, 1, in_view);
        p->stats.points += points;
        p->stats.lights += points * lights;
        p->stats.reused += points * lights;
        return;
    }
    memset(&one, 0, sizeof one);
    one.s = s;
    one.set = set;
    one.first = index;
    one.lanes = 1;
#ifndef SFIELD_WITHOUT_GLOSS
    one.chains = (int)p->chains;
#endif
    sfield__load_lanes(&one);
    for (k = 0; k < 3; k++) {
        x[k] = one.p[16 * k];
        n[k] = one.n[16 * k];
    }
    p->rgb = rgb;
    if (one.in_view) {
        p->stats.points++;
        p->stats.lights += lights;
#ifndef SFIELD_WITHOUT_GLOSS
        if (one.chains > 1) sfield__light_gloss(p, &one, hash, set->ambient ? &ambient : NULL);
        else
#endif
            sfield__light_point(p, index, x, n, hash, set->ambient ? &ambient : NULL);
    }
    p->rgb = NULL;
    for (k = 0; k < 3 && set->rgb; k++) set->rgb[3 * index + k] = rgb[k] * 0.318309886f;
    if (set->ambient) set->ambient[index] = ambient;
    if (set->cache) {
        sfield__last now;
        memset(&now, 0, sizeof now);
        now.seen = sfield__hash(p->set_hash, s->now_hash);
        memcpy(now.middle, x, sizeof now.middle);
        now.in_view = in_view;
        now.active = one.active;
        sfield__keep_results(set, index, index, 1, &now);
    }
}
