/* ---- files in place: no copy, and budgets ---- */

/* Reads and checks the header of a plain or packed file, and compares the file's size; nothing else is read.
   *longest receives how many segments the longest list of a packed file has, or 0 where the block is there
   as it is; *at where the block's header begins. What is wrong with a packed file's sizes is found here too,
   so that no room is made for what cannot be opened. */
static cohsm_result cohsm__file_header(const uint8_t *file, size_t bytes, cohsm__header *h, uint32_t *longest,
                                       size_t *at)
{
    *at = 0;
    *longest = 0;
    if (bytes < 16) return COHSM_ERR_FORMAT;
    if (cohsm__get_u32(file) == COHSM__PACK_MAGIC) {
#ifdef COHSM_WITHOUT_PACK
        return COHSM_ERR_MISMATCH;
#else
        if (cohsm__get_u32(file + 4) != COHSM__PACK_FORMAT) return COHSM_ERR_VERSION;
        if (cohsm__get_u32(file + 8) != bytes || bytes < COHSM__PACK_HEADER + sizeof *h)
            return COHSM_ERR_FORMAT;
        *longest = cohsm__get_u32(file + 12);
        *at = COHSM__PACK_HEADER;
#endif
    }
    if (cohsm__get_u32(file + *at) != COHSM__MAGIC) return COHSM_ERR_FORMAT;
    if (cohsm__get_u32(file + *at + 4) != COHSM__FORMAT) return COHSM_ERR_VERSION;
    if (bytes - *at < sizeof *h) return COHSM_ERR_FORMAT;
    memcpy(h, file + *at, sizeof *h);
    cohsm__host_words((uint32_t *)(void *)h, COHSM__HEADER_WORDS);
    if (!cohsm__header_sound(h)) return COHSM_ERR_FORMAT;
    if (*longest == 0 && bytes - *at != 4 * (size_t)h->words) return COHSM_ERR_FORMAT;
#ifndef COHSM_WITHOUT_PACK
    if (*longest && !cohsm__packed_sound(h, *longest, bytes)) return COHSM_ERR_FORMAT;
#endif
    return COHSM_OK;
}

/* Returns the bytes of memory that a file with this header asks for at once, trays aside. */
static uint64_t cohsm__file_cost(const cohsm__header *h, uint32_t longest, int in_place)
{
    uint64_t cost = sizeof(cohsm_maps);
    if (h->domain == COHSM_DOMAIN_LATLONG) cost += 8 * ((uint64_t)h->side[0] + h->side[1]);
    if (!in_place) cost += 4 * (uint64_t)h->words + 64u;
#ifndef COHSM_WITHOUT_PACK
    if (longest) cost += cohsm__pack_work(h, longest) + sizeof(cohsm__odds);
#else
    (void)longest;
#endif
    return cost;
}

/* Logs what is wrong with a file, or that memory was short. Returns the result. */
static cohsm_result cohsm__log_file(const cohsm__logger *log, cohsm_result result)
{
    if (result == COHSM_ERR_FORMAT) cohsm__log_text(log, "data", "is no file of csm.h, or a damaged one");
    if (result == COHSM_ERR_VERSION) cohsm__log_text(log, "data", "is a file of an unknown version");
    if (result == COHSM_ERR_MISMATCH)
        cohsm__log_text(log, "data", "is a packed file, and this csm.h was joined without pack");
    if (result == COHSM_ERR_MEMORY) cohsm__log_text(log, "data", "is not at a multiple of 64 bytes");
    return cohsm__log_result(log, result);
}

/* Makes maps of a plain file whose header is sound where it lies. */
static cohsm_result cohsm__open_in_place(const uint8_t *data, const cohsm__header *h,
                                         const cohsm__allocator *a, const cohsm__part *part, cohsm_maps **out)
{
    cohsm__memory block;
    block.memory = NULL;                /* what tells cohsm_free that there is nothing to give back */
    block.words = (uint32_t *)(uintptr_t)data;      /* the words of maps are const: nobody writes to them */
    if (cohsm__block_crc(block.words, h->words) != h->crc) return COHSM_ERR_FORMAT;
    return cohsm__open_block(a, *part, block, out);
}

/* Gives maps the layout of the desc within its budget, of which the maps take `cost`, and hands them out; if
   this fails, frees them. Trays that do not fit are none, or refused where they were asked for. */
static cohsm_result cohsm__lay_out_within(cohsm_maps *maps, const cohsm_open_desc *d, uint64_t cost,
                                          cohsm__part part, cohsm_maps **out)
{
    const size_t block = 4 * (size_t)maps->head.words;
    cohsm__wish wish;
    cohsm_result result;

    wish.layout = d->layout;
    wish.bytes = d->layout_bytes;
    wish.system = &d->system;
    if (d->budget_bytes && d->layout != COHSM_LAYOUT_COMPACT) {
        const size_t room = d->budget_bytes - (size_t)cost;
        const size_t most = room > SIZE_MAX - block ? SIZE_MAX : block + room;
        if (d->layout != COHSM_LAYOUT_BUDGET || wish.bytes > most) wish.bytes = most;
        wish.layout = COHSM_LAYOUT_BUDGET;
    }
    result = cohsm__lay_out_opened(maps, &wish, part, &maps);
    if (result != COHSM_OK) return result;
#ifndef COHSM_WITHOUT_FAST
    if (d->budget_bytes && d->layout == COHSM_LAYOUT_FAST && !maps->trays.lines) {
        cohsm_free(maps);
        return COHSM_ERR_LIMIT;
    }
#endif
    *out = maps;
    return COHSM_OK;
}

/* A file that is being opened: what its header said, and where it may lie. */
typedef struct cohsm__opening {
    const uint8_t *data;
    size_t         bytes;
    cohsm__header  head;
    uint32_t       longest;
    int            in_place;            /* the wish; then whether the file is read where it lies */
    uint64_t       cost;                /* cohsm__file_cost */
} cohsm__opening;

/* Reads the header of o->data, of o->bytes, and finds how the file will be opened. */
static cohsm_result cohsm__opening_start(cohsm__opening *o)
{
    size_t at;
    cohsm_result result = cohsm__file_header(o->data, o->bytes, &o->head, &o->longest, &at);
    if (result != COHSM_OK) return result;
    o->in_place = o->in_place && at == 0 && cohsm__host_is_little_endian();
    o->cost = cohsm__file_cost(&o->head, o->longest, o->in_place);
    return o->in_place && (uintptr_t)o->data % 64u ? COHSM_ERR_MEMORY : COHSM_OK;
}

static cohsm_result cohsm__opening_end(const cohsm__opening *o, const cohsm__allocator *a,
                                       const cohsm__part *part, cohsm_maps **out)
{
    if (o->in_place) return cohsm__open_in_place(o->data, &o->head, a, part, out);
    return cohsm__open_file(o->data, o->bytes, a, part, out);
}

static cohsm_result cohsm__open_within(const cohsm_open_desc *d, const void *data, size_t bytes,
                                       const cohsm__logger *log, cohsm_maps **out)
{
    cohsm__opening o;
    cohsm__allocator a;
    cohsm__part part, opening;
    cohsm_maps *maps = NULL;
    cohsm_result result;

    if (!cohsm__services_of(&d->system, log, &a, &part)) return COHSM_ERR_DESC;
    o.data = (const uint8_t *)data;
    o.bytes = bytes;
    o.in_place = d->in_place;
    result = cohsm__opening_start(&o);
    if (result == COHSM_OK && d->budget_bytes && o.cost > d->budget_bytes) {
        cohsm__log_bound(log, "desc.budget_bytes", d->budget_bytes, "at least", o.cost,
                         "what the file takes");
        return COHSM_ERR_LIMIT;
    }
    opening = cohsm__part_of(&part, 0.0f, d->layout == COHSM_LAYOUT_COMPACT ? 1.0f : 0.5f);
    if (result == COHSM_OK) result = cohsm__opening_end(&o, &a, &opening, &maps);
    if (result != COHSM_OK) return cohsm__log_file(log, result);
    result = cohsm__lay_out_within(maps, d, o.cost, cohsm__part_of(&part, 0.5f, 1.0f), out);
    if (result == COHSM_ERR_LIMIT) cohsm__log_text(log, "desc.layout", "asks for more trays than may be");
    return cohsm__log_result(log, result);
}

COHSM_DEF cohsm_result cohsm_open_file(const cohsm_open_desc *desc, const void *data, size_t bytes,
                                       cohsm_maps **out)
{
    cohsm_open_desc none;
    cohsm__logger log = cohsm__logger_of(desc ? &desc->system : NULL, "cohsm_open_file");

    memset(&none, 0, sizeof none);
    if (!desc) desc = &none;
    if (!data) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "data", "is NULL");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if ((unsigned)desc->layout >= COHSM_LAYOUT_COUNT)
        return cohsm__refuse_value(&log, "desc.layout", (double)desc->layout, "a COHSM_LAYOUT_...");
    return cohsm__open_within(desc, data, bytes, &log, out);
}

/* Makes of zeroed maps ones without a block, which know no more than a header says: enough for facts, for
   checks of queries, and for the sphere outside which they shadow nothing. */
static void cohsm__maps_of_header(cohsm_maps *m, const cohsm__header *h)
{
    m->head = *h;
    m->range = h->pixel_end - h->pixel_begin;
    m->simd = cohsm__simd();
    cohsm__dop_in_radii(m);
}

COHSM_DEF cohsm_result cohsm_file_info(const void *data, size_t bytes, const cohsm_system *system,
                                       cohsm_info *out)
{
    cohsm__logger log = cohsm__logger_of(system, "cohsm_file_info");
    cohsm__header h;
    cohsm_maps maps;
    uint32_t longest;
    size_t at;
    cohsm_result result;

    if (!data) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "data", "is NULL");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    result = cohsm__file_header((const uint8_t *)data, bytes, &h, &longest, &at);
    if (result != COHSM_OK) return cohsm__log_file(&log, result);
    memset(&maps, 0, sizeof maps);
    cohsm__maps_of_header(&maps, &h);
    maps.memory = &maps;                        /* a copy, as cohsm_open makes it */
    cohsm_get_info(&maps, out);
    return COHSM_OK;
}
