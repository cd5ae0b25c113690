/* ---- shading: lazy occlusion updating ---- */

SFIELD_DEF sfield_result sfield_cache_create(const sfield_scene *s, size_t point_count, uint32_t light_count,
                                             sfield_cache **out)
{
    sfield_cache *c;
    size_t own, units, lanes, values, bytes;
    uint8_t *at;
    if (!s || !out || !point_count || !light_count || light_count > 65536 || point_count > 0x7fffffffu)
        return SFIELD_ERR_ARGUMENT;
    own = s->algebra ? (point_count + 15) / 16 : point_count;
    if (!sfield__mul_size(own, light_count, &units) || units > SIZE_MAX / 16384) return SFIELD_ERR_ALLOC;
    lanes = units * (s->algebra ? 32 : 1);          /* marks as many as lights */
    values = lanes * (s->algebra ? s->coefs : (uint32_t)SFIELD__CACHED);
    bytes = sizeof *c + (units + own) * sizeof *c->hash + lanes * sizeof *c->scale +
            (s->algebra ? 2 * values + own : 4 * values + 3 * own * sizeof *c->sky);
    at = (uint8_t *)sfield__alloc(&s->allocator, bytes);
    if (!at) return SFIELD_ERR_ALLOC;
    c = (sfield_cache *)(void *)at;
    memset(c, 0, sizeof *c);
    c->allocator = s->allocator;
    c->points = point_count;
    c->bytes = bytes;
    c->lights = light_count;
    c->coefs = s->coefs;
    c->cells = s->algebra ? 0 : s->cells;
    c->hash = (uint64_t *)(void *)(at + sizeof *c);
    c->lit = c->hash + units;
    c->scale = (float *)(void *)(c->lit + own);
    c->sky = c->scale + lanes;
    c->value = (int16_t *)(void *)(c->sky + (s->algebra ? 0 : 3 * own));
    c->index = s->algebra ? NULL : (uint16_t *)(c->value + values);
    c->marks = (uint8_t *)(c->value + values);
    memset(c->hash, 0, (size_t)((uint8_t *)c->scale - (uint8_t *)c->hash));
    *out = c;
    return SFIELD_OK;
}

SFIELD_DEF void sfield_cache_free(sfield_cache *cache)
{
    sfield__allocator a;
    if (!cache) return;
    a = cache->allocator;
    sfield__free(&a, cache);
}

SFIELD_DEF size_t sfield_cache_bytes(const sfield_cache *cache) { return cache ? cache->bytes : 0; }

/* Smaller T are kept as 0: 32767 over them would pass what a float holds. */
#define SFIELD__LEAST_T 1e-30f

static uint64_t sfield__hash(uint64_t h, uint64_t x)
{
    h = (h ^ x) * 0x9e3779b97f4a7c15u;
    return h ^ h >> 29;
}

static uint64_t sfield__hash_bytes(uint64_t h, const void *data, size_t words)
{
    const uint8_t *p = (const uint8_t *)data;
    for (; words; words--, p += 4) {
        uint32_t x;
        memcpy(&x, p, sizeof x);
        h = sfield__hash(h, x);
    }
    return h;
}

/* Hashes what T of a set depends on besides occluders: all bodies, and where its points stand. An entity that
   shines and hides nothing moves without a new version, since lamps do; points that lie on it move with
   it. */
static uint64_t sfield__hash_stand(const sfield_scene *s, const sfield_points *set)
{
    uint64_t h = sfield__hash(s->version, (uint64_t)(uintptr_t)s);
    h = sfield__hash(h, (uint64_t)(uintptr_t)set->self);
    h = sfield__hash(h, (uint64_t)set->entity << 32 | (set->self ? set->self->h.crc : 0));
    if (set->entity) h = sfield__hash_bytes(h, s->item[set->entity - 1].e.transform, 16);
    return h;
}

static void sfield__keep_tile(sfield_cache *c, size_t slot, const float *t)
{
    uint32_t k, l;
    int16_t *value = c->value + slot * c->coefs * SFIELD__LANES;
    for (l = 0; l < SFIELD__LANES; l++) {
        float most = 0, inverse;
        for (k = 0; k < c->coefs; k++) {
            float x = fabsf(t[k * SFIELD__LANES + l]);
            most = x > most ? x : most;
        }
        c->scale[slot * SFIELD__LANES + l] = most / 32767;
        inverse = most > SFIELD__LEAST_T ? 32767 / most : 0;
        for (k = 0; k < c->coefs; k++) {
            float q = t[k * SFIELD__LANES + l] * inverse;
            value[k * SFIELD__LANES + l] = (int16_t)(q + (q < 0 ? -0.5f : 0.5f));
        }
    }
}

static void sfield__recall_tile(const sfield_cache *c, size_t slot, float *t, int simd)
{
    const int16_t *value = c->value + slot * c->coefs * SFIELD__LANES;
    const float *scale = c->scale + slot * SFIELD__LANES;
    sfield__recall16(value, scale, c->coefs, t, simd);
}

/* Returns where T after `number` steps of the way is kept: behind what lights keep. */
static size_t sfield__mark_slot(const sfield_cache *c, size_t tile, uint32_t number)
{
    return ((c->points + 15) / 16 + tile) * c->lights + number - 1;
}
