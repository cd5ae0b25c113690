/* ---- shading: lazy occlusion updating ---- */

/* Returns how many floats a cache keeps of the results of a point. */
static uint32_t sfield__results_of(const sfield_cache *c) { return c->chains > 1 ? 10 : 4; }

/* Makes room for so many T of each point and light, and forgets all that was kept. Without memory the cache
   stays as it was. */
static sfield_result sfield__lay_cache(sfield_cache *c, uint32_t chains)
{
    const size_t own = c->cells ? c->points : (c->points + 15) / 16, skies = c->cells ? own * chains : 0;
    sfield_cache n = *c;
    size_t units, hashes, lanes;
    size_t values, bytes;
    uint8_t *at;
    if (!sfield__mul_size(own, (size_t)c->lights * chains, &units) || units > SIZE_MAX / 16384)
        return SFIELD_ERR_ALLOC;
    n.chains = chains;
    hashes = c->cells ? units : units / chains;
    lanes = units * (c->cells ? 1 : 32);            /* marks as many as lights */
    values = lanes * (c->cells ? (uint32_t)SFIELD__CACHED : c->coefs);
    bytes = (hashes + (c->cells ? skies : own)) * sizeof *n.hash + own * sizeof *n.last +
            sfield__results_of(&n) * c->points * sizeof *n.result + lanes * sizeof *n.scale +
            (c->cells ? 4 * values + 3 * skies * sizeof *n.sky : 2 * values + own);
    at = (uint8_t *)sfield__alloc(&c->allocator, bytes);
    if (!at) return SFIELD_ERR_ALLOC;
    n.bytes = sizeof n + bytes;
    n.hash = (uint64_t *)(void *)at;
    n.lit = n.hash + hashes;
    n.last = (sfield__last *)(void *)(n.lit + (c->cells ? skies : own));
    n.result = (float *)(void *)(n.last + own);
    n.scale = n.result + sfield__results_of(&n) * c->points;
    n.sky = n.scale + lanes;
    n.value = (int16_t *)(void *)(n.sky + 3 * skies);
    n.index = c->cells ? (uint16_t *)(n.value + values) : NULL;
    n.marks = (uint8_t *)(n.value + values);
    memset(n.hash, 0, (size_t)((uint8_t *)n.result - at));
    sfield__free(&c->allocator, c->hash);
    *c = n;
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_cache_create(const sfield_scene *s, size_t point_count, uint32_t light_count,
                                             sfield_cache **out)
{
    sfield__logger log;
    sfield_cache *c;
    if (!s) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&s->desc.system, "sfield_cache_create");
    if (!out) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "out", "is NULL");
    if (!sfield__check_value(&log, point_count && point_count <= 0x7fffffffu, "point_count",
                             (double)point_count, "1..2^31 - 1") ||
        !sfield__check_value(&log, light_count && light_count <= 65536, "light_count", light_count,
                             "1..65536"))
        return SFIELD_ERR_ARGUMENT;
    c = (sfield_cache *)sfield__alloc(&s->allocator, sizeof *c);
    if (!c) return SFIELD_ERR_ALLOC;
    memset(c, 0, sizeof *c);
    c->allocator = s->allocator;
    c->points = point_count;
    c->lights = light_count;
    c->coefs = s->coefs;
    c->cells = s->algebra ? 0 : s->cells;
    if (sfield__lay_cache(c, 1) != SFIELD_OK) {
        sfield_cache_free(c);
        return SFIELD_ERR_ALLOC;
    }
    *out = c;
    return SFIELD_OK;
}

SFIELD_DEF void sfield_cache_free(sfield_cache *cache)
{
    sfield__allocator a;
    if (!cache) return;
    a = cache->allocator;
    sfield__free(&a, cache->hash);
    sfield__free(&a, cache);
}

SFIELD_DEF size_t sfield_cache_bytes(const sfield_cache *cache) { return cache ? cache->bytes : 0; }

/* The least T that the cache keeps; a smaller one becomes 0, since 32767 divided by it might be beyond
   floats. */
#define SFIELD__LEAST_T 1e-30f

/* Hashes all that T of a set depends on besides the occluders before each light and, with gloss, the BRDFs:
   how the scene computes, and where the points are. Points that lie on an entity move with it. The number of
   occluders decides where T is rounded between lights (sfield__chain_products). */
static uint64_t sfield__hash_set(const sfield_scene *s, const sfield_points *set)
{
    const uint32_t how[5] = { (uint32_t)s->desc.product, s->coefs, s->occluder_count, set->entity,
                              s->has_sky || s->has_sun };
    uint64_t h = sfield__hash_bytes((uint64_t)(uintptr_t)s, how, 5);
    h = sfield__hash_bytes(h, &s->desc.reach, 1);
    h = sfield__hash(h, (uint64_t)(uintptr_t)set->self);
    if (set->self) h = sfield__hash(h, set->self->h.crc);
    if (set->entity) h = sfield__hash_bytes(h, s->item[set->entity - 1].e.transform, 16);
    return h;
}

/* Returns q rounded to 16 bits. What is not in their range, as where T is no number, becomes 0. */
static int16_t sfield__to_int16(float q)
{
    if (!(fabsf(q) < 32767.5f)) return 0;
    return (int16_t)(q + (q < 0 ? -0.5f : 0.5f));
}

/* Returns the scale of values whose largest is `most`: 0 if that is beyond floats. */
static float sfield__scale_of(float most) { return sfield__finite(most) ? most / 32767 : 0; }

/* Keeps all T of a tile in a slot. */
static void sfield__keep_tile(sfield_cache *c, size_t slot, const float *t, uint32_t chains)
{
    float *scale = c->scale + slot * c->chains * SFIELD__LANES;
    int16_t *value = c->value + slot * c->chains * c->coefs * SFIELD__LANES;
    uint32_t k, l;
    for (; chains > 0; chains--) {
        for (l = 0; l < SFIELD__LANES; l++) {
            float most = 0, inverse;
            for (k = 0; k < c->coefs; k++) {
                float x = fabsf(t[k * SFIELD__LANES + l]);
                most = x > most ? x : most;
            }
            scale[l] = sfield__scale_of(most);
            inverse = most > SFIELD__LEAST_T ? 32767 / most : 0;
            for (k = 0; k < c->coefs; k++)
                value[k * SFIELD__LANES + l] = sfield__to_int16(t[k * SFIELD__LANES + l] * inverse);
        }
        scale += SFIELD__LANES;
        value += c->coefs * SFIELD__LANES;
        t += c->coefs * SFIELD__LANES;
    }
}

static void sfield__recall_tile(const sfield_cache *c, size_t slot, float *t, uint32_t chains, int simd)
{
    const int16_t *value = c->value + slot * c->chains * c->coefs * SFIELD__LANES;
    const float *scale = c->scale + slot * c->chains * SFIELD__LANES;
    for (; chains > 0; chains--) {
        sfield__recall16(value, scale, c->coefs, t, simd);
        scale += SFIELD__LANES;
        value += c->coefs * SFIELD__LANES;
        t += c->coefs * SFIELD__LANES;
    }
}

/* Returns the slot of T after `number` of the steps that all lights share. These slots come after those of
   lights. */
static size_t sfield__mark_slot(const sfield_cache *c, size_t tile, uint32_t number)
{
    return ((c->points + 15) / 16 + tile) * c->lights + number - 1;
}

/* ---- results of the last frame ---- */

enum { SFIELD__HAS_RGB = 1, SFIELD__HAS_AMBIENT = 2, SFIELD__HAS_GLOSS = 4, SFIELD__HAS_GRAZING = 8 };

/* Returns the results that a set asks for, as bits. */
static int sfield__wanted_of(const sfield_points *set)
{
    return (set->rgb ? SFIELD__HAS_RGB : 0) | (set->ambient ? SFIELD__HAS_AMBIENT : 0) |
           (set->gloss ? SFIELD__HAS_GLOSS : 0) | (set->gloss && set->grazing ? SFIELD__HAS_GRAZING : 0);
}

/* Returns the bits of the points that are in view, as the caller says. */
static uint32_t sfield__bits_in_view(const sfield_points *set, size_t first, uint32_t count)
{
    uint32_t l, bits = 0;
    for (l = 0; l < count; l++) bits |= (uint32_t)(!set->in_view || set->in_view[first + l]) << l;
    return bits;
}

/* Returns whether an occluder that stood or stands at c may hide something of the sphere about some points.
   The test is wider than the one that leaves occluders out, by as much as roundings can matter. */
static int sfield__may_hide(const sfield__last *last, const float *c, float reach)
{
    float x = c[0] - last->middle[0], y = c[1] - last->middle[1], z = c[2] - last->middle[2];
    return sqrtf(x * x + y * y + z * z) - last->extent < 1.0001f * reach;
}

/* Returns whether the results of a unit (a tile or a point) in the last frame still hold. They do if nothing
   changed but occluders that were, and are, out of its reach, and if the same points are in view: which of
   these share samples of a field decides the last bits. The test costs a few comparisons for each occluder
   that moved. */
static int sfield__is_untouched(const sfield_scene *s, const sfield_points *set, uint64_t set_hash,
                                size_t unit, uint32_t in_view)
{
    sfield__last *last = &set->cache->last[unit];
    uint32_t i;
    if (!last->seen || ((in_view ^ last->in_view) & last->active) || (sfield__wanted_of(set) & ~last->has))
        return 0;
    if (last->seen == sfield__hash(set_hash, s->now_hash)) return 1;
    if (!s->before_hash || last->seen != sfield__hash(set_hash, s->before_hash)) return 0;
    for (i = 0; i < s->moved_count; i++) {
        const sfield__item *it = &s->item[s->moved[i]];
        if (sfield__may_hide(last, it->was, it->reach) || sfield__may_hide(last, it->center[0], it->reach))
            return 0;
    }
    last->seen = sfield__hash(set_hash, s->now_hash);
    return 1;
}

/* Writes the results of the last frame again, 0 for points that are not in view. Returns how many are. */
static uint32_t sfield__repeat_results(const sfield_points *set, size_t unit, size_t first, uint32_t count,
                                       uint32_t in_view)
{
    const uint32_t results = sfield__results_of(set->cache);
    const float *result = set->cache->result + results * first;
    uint32_t l, k;
    in_view &= set->cache->last[unit].active;
    for (l = 0; l < count; l++, result += results) {
        const int here = in_view >> l & 1, glossy = here && results > 4;
        const size_t at = 3 * (first + l);
        for (k = 0; k < 3 && set->rgb; k++) set->rgb[at + k] = here ? result[k] : 0.0f;
        if (set->ambient) set->ambient[first + l] = here ? result[3] : 0.0f;
        for (k = 0; k < 3 && set->gloss; k++) set->gloss[at + k] = glossy ? result[4 + k] : 0.0f;
        for (k = 0; k < 3 && set->gloss && set->grazing; k++)
            set->grazing[at + k] = glossy ? result[7 + k] : 0.0f;
    }
    return sfield__popcount(in_view);
}

/* Keeps the results that were just written for a unit of points. */
static void sfield__keep_results(const sfield_points *set, size_t unit, size_t first, uint32_t count,
                                 const sfield__last *now)
{
    const uint32_t results = sfield__results_of(set->cache);
    sfield__last *last = &set->cache->last[unit];
    float *result = set->cache->result + results * first;
    uint32_t l, k;
    *last = *now;
    last->has = sfield__wanted_of(set);
    for (l = 0; l < count; l++, result += results) {
        const size_t at = 3 * (first + l);
        for (k = 0; k < 3; k++) result[k] = set->rgb ? set->rgb[at + k] : 0.0f;
        result[3] = set->ambient ? set->ambient[first + l] : 0.0f;
        for (k = 0; k < 3 && results > 4; k++) {
            result[4 + k] = set->gloss ? set->gloss[at + k] : 0.0f;
            result[7 + k] = set->gloss && set->grazing ? set->grazing[at + k] : 0.0f;
        }
    }
}
