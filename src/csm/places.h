/* ---- places: few maps that stand for many ---- */

enum { COHSM__MOST_CANDIDATES = 16384, COHSM__MOST_EXCHANGES = 8 };

typedef struct cohsm__placing {
    uint32_t  count, place_count;       /* candidates, places */
    size_t    words;                    /* of bits for each candidate */
    uint32_t *bits;                     /* whether each receiver is lit from there */
    uint32_t *apart;                    /* count x count: receivers whose answers differ */
    uint32_t *best, *second;            /* of each candidate: the least of its `apart` to a place, the next */
    uint32_t *of;                       /* which candidate is the place that has the least */
    uint8_t  *chosen;
} cohsm__placing;

static void cohsm__placing_free(const cohsm__placing *c, const cohsm__allocator *a)
{
    cohsm__free(a, c->bits);
    cohsm__free(a, c->apart);
    cohsm__free(a, c->best);
    cohsm__free(a, c->second);
    cohsm__free(a, c->of);
    cohsm__free(a, c->chosen);
}

static int cohsm__placing_make(cohsm__placing *c, const cohsm__allocator *a, uint32_t count, size_t receivers)
{
    size_t pairs, all;
    memset(c, 0, sizeof *c);
    c->count = count;
    c->words = (receivers + 31u) / 32u;
    if (!cohsm__mul_size(count, count, &pairs) || !cohsm__mul_size(count, c->words, &all)) return 0;
    c->bits = (uint32_t *)cohsm__alloc_array(a, all, 4);
    c->apart = (uint32_t *)cohsm__alloc_array(a, pairs, 4);
    c->best = (uint32_t *)cohsm__alloc_array(a, count, 4);
    c->second = (uint32_t *)cohsm__alloc_array(a, count, 4);
    c->of = (uint32_t *)cohsm__alloc_array(a, count, 4);
    c->chosen = (uint8_t *)cohsm__alloc_array(a, count, 1);
    if (!c->bits || !c->apart || !c->best || !c->second || !c->of || !c->chosen) return 0;
    memset(c->bits, 0, 4 * all);
    memset(c->chosen, 0, count);
    return 1;
}

/* Asks each candidate's map for all receivers. */
static cohsm_result cohsm__placing_ask(const cohsm__placing *c, const cohsm_places_desc *d, float *visible,
                                      const cohsm__part *part)
{
    cohsm_query q;
    uint32_t i;
    size_t k;
    cohsm_result result = COHSM_OK;

    memset(&q, 0, sizeof q);
    q.count = d->receiver_count;
    q.positions = d->receivers;
    q.position_stride = d->receiver_stride;
    q.one_light = 1;
    q.light_kind = COHSM_LIGHT_INDEX;
    q.bias = d->bias;
    for (i = 0; i < c->count && result == COHSM_OK; i++) {
        if (cohsm__cancelled(part, i, c->count, 1)) return COHSM_ERR_CANCELLED;
        q.lights = &i;
        result = cohsm_visible(d->candidates, &q, visible, NULL);
        for (k = 0; k < q.count && result == COHSM_OK; k++)
            if (visible[k] > 0.5f) c->bits[c->words * i + k / 32] |= 1u << k % 32;
    }
    return result;
}

/* Counts for each pair of candidates the receivers whose answers differ. */
static cohsm_result cohsm__placing_compare(const cohsm__placing *c, const cohsm__part *part)
{
    uint32_t i, j, n;
    size_t w;

    for (i = 0; i < c->count; i++) {
        const uint32_t *a = c->bits + c->words * i;
        if (cohsm__cancelled(part, i, c->count, 1)) return COHSM_ERR_CANCELLED;
        for (j = 0; j <= i; j++) {
            const uint32_t *b = c->bits + c->words * j;
            for (w = 0, n = 0; w < c->words; w++) n += cohsm__popcount(a[w] ^ b[w]);
            c->apart[(size_t)i * c->count + j] = c->apart[(size_t)j * c->count + i] = n;
        }
    }
    return COHSM_OK;
}

/* Finds for each candidate the place that stands for it, and the second best. Returns the sum of errors. */
static uint64_t cohsm__placing_assign(const cohsm__placing *c)
{
    uint64_t sum = 0;
    uint32_t i, j;

    for (i = 0; i < c->count; i++) {
        c->best[i] = c->second[i] = UINT32_MAX;
        for (j = 0; j < c->count; j++) {
            const uint32_t n = c->apart[(size_t)i * c->count + j];
            if (!c->chosen[j]) continue;
            if (n < c->best[i]) {
                c->second[i] = c->best[i];
                c->best[i] = n;
                c->of[i] = j;
            } else if (n < c->second[i]) c->second[i] = n;
        }
        sum += c->best[i];
    }
    return sum;
}

/* Returns the candidate that would lower the sum of errors most as one more place, and writes by how much.
   Errors are those of best[], or, of candidates whose place is `without`, of second[]. */
static uint32_t cohsm__placing_next(const cohsm__placing *c, uint32_t without, int64_t *gain)
{
    uint32_t i, j, found = 0;

    *gain = -1;
    for (j = 0; j < c->count; j++) {
        const uint32_t *row = c->apart + (size_t)j * c->count;
        int64_t sum = 0;
        if (c->chosen[j]) continue;
        for (i = 0; i < c->count; i++) {
            const uint32_t now = c->of[i] == without ? c->second[i] : c->best[i];
            if (row[i] < now) sum += (int64_t)now - row[i];
        }
        if (sum <= *gain) continue;
        *gain = sum;
        found = j;
    }
    return found;
}

/* Chooses one place after the other. */
static cohsm_result cohsm__placing_grow(cohsm__placing *c, uint32_t wanted, const cohsm__part *part)
{
    uint32_t i, next;
    int64_t gain;

    for (i = 0; i < c->count; i++) {
        c->best[i] = (uint32_t)(32 * c->words) + 1u;    /* worse than any place */
        c->of[i] = UINT32_MAX;
    }
    for (c->place_count = 0; c->place_count < wanted; c->place_count++) {
        if (cohsm__cancelled(part, c->place_count, wanted, 1)) return COHSM_ERR_CANCELLED;
        next = cohsm__placing_next(c, UINT32_MAX - 1u, &gain);
        c->chosen[next] = 1;
        for (i = 0; i < c->count; i++) {
            const uint32_t n = c->apart[(size_t)next * c->count + i];
            if (n >= c->best[i]) continue;
            c->best[i] = n;
            c->of[i] = next;
        }
    }
    return COHSM_OK;
}

/* Exchanges each place for the candidate that lowers the errors most, once through all places. *changed
   receives 0 if there was no exchange that lowered them. */
static cohsm_result cohsm__placing_exchange(const cohsm__placing *c, const cohsm__part *part, int *changed)
{
    uint64_t lost;
    uint32_t j, i, next;
    int64_t gain;

    *changed = 0;
    (void)cohsm__placing_assign(c);
    for (j = 0; j < c->count && c->place_count > 1; j++) {
        if (!c->chosen[j]) continue;
        if (cohsm__cancelled(part, j, c->count, 1)) return COHSM_ERR_CANCELLED;
        for (i = 0, lost = 0; i < c->count; i++) lost += c->of[i] == j ? c->second[i] - c->best[i] : 0u;
        next = cohsm__placing_next(c, j, &gain);
        if (gain <= (int64_t)lost) continue;
        c->chosen[j] = 0;
        c->chosen[next] = 1;
        (void)cohsm__placing_assign(c);
        *changed = 1;
    }
    return COHSM_OK;
}

static cohsm_result cohsm__place_all(cohsm__placing *c, const cohsm_places_desc *d, float *visible,
                                     const cohsm__part *part)
{
    cohsm__part step = cohsm__part_of(part, 0.0f, 0.4f);
    cohsm_result result = cohsm__placing_ask(c, d, visible, &step);
    int i, changed = 1;

    step = cohsm__part_of(part, 0.4f, 0.7f);
    if (result == COHSM_OK) result = cohsm__placing_compare(c, &step);
    step = cohsm__part_of(part, 0.7f, 0.8f);
    if (result == COHSM_OK) result = cohsm__placing_grow(c, d->place_count, &step);
    for (i = 0; i < COHSM__MOST_EXCHANGES && changed && result == COHSM_OK; i++) {
        step = cohsm__part_of(part, 0.8f + 0.2f * (float)i / (float)COHSM__MOST_EXCHANGES,
                              0.8f + 0.2f * (float)(i + 1) / (float)COHSM__MOST_EXCHANGES);
        result = cohsm__placing_exchange(c, &step, &changed);
    }
    return result;
}

/* Checks what is asked for. */
static cohsm_result cohsm__check_places(const cohsm_places_desc *d, const cohsm__logger *log)
{
    uint32_t count;
    if (!d->candidates) return cohsm__refuse(log, COHSM_ERR_DESC, "desc.candidates", "is NULL");
    if (!d->receivers) return cohsm__refuse(log, COHSM_ERR_DESC, "desc.receivers", "is NULL");
    count = d->candidates->head.map_count;
    if (count > COHSM__MOST_CANDIDATES)
        return cohsm__refuse_value(log, "the number of candidates", (double)count, "at most 16,384");
    if (!d->receiver_count || d->receiver_count > 1u << 28)
        return cohsm__refuse_value(log, "desc.receiver_count", (double)d->receiver_count, "1..2^28");
    if (!cohsm__stride_valid(d->receiver_stride, 12))
        return cohsm__refuse_value(log, "desc.receiver_stride", (double)d->receiver_stride,
                                   "0, or a multiple of 4 from 12 on");
    if (!cohsm__finite(d->bias)) return cohsm__refuse_value(log, "desc.bias", (double)d->bias, "finite");
    if (!d->place_count || d->place_count > count)
        return cohsm__refuse_value(log, "desc.place_count", (double)d->place_count,
                                   "1 or more, and at most the number of candidates");
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_places_choose(const cohsm_places_desc *desc, uint32_t *places, uint32_t *instead,
                                           double *error)
{
    cohsm__logger log = cohsm__logger_of(desc ? &desc->system : NULL, "cohsm_places_choose");
    cohsm__allocator a;
    cohsm__part part;
    cohsm__placing c;
    float *visible;
    uint32_t i, n;
    cohsm_result result;

    if (!desc) return COHSM_ERR_ARGUMENT;
    if (!places) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "places", "is NULL");
    if (!instead) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "instead", "is NULL");
    if (!cohsm__services_of(&desc->system, &log, &a, &part)) return COHSM_ERR_DESC;
    result = cohsm__check_places(desc, &log);
    if (result != COHSM_OK) return result;
    visible = (float *)cohsm__alloc_array(&a, desc->receiver_count, sizeof *visible);
    if (!cohsm__placing_make(&c, &a, desc->candidates->head.map_count, desc->receiver_count) || !visible)
        result = COHSM_ERR_ALLOC;
    if (result == COHSM_OK) result = cohsm__place_all(&c, desc, visible, &part);
    if (result == COHSM_OK) {
        const double sum = (double)cohsm__placing_assign(&c);
        if (error) *error = sum / ((double)c.count * (double)desc->receiver_count);
        for (i = 0, n = 0; i < c.count; i++) {          /* best: the number of a candidate among the places */
            c.best[i] = n;
            if (c.chosen[i]) places[n++] = i;
        }
        for (i = 0; i < c.count; i++) instead[i] = c.best[c.of[i]];
    }
    cohsm__placing_free(&c, &a);
    cohsm__free(&a, visible);
    return cohsm__log_result(&log, result);
}
