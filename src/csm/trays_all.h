/* ---- trays: all of a block, in memory ---- */

/* All columns are gone through twice: once to count their lines, and once to write them. */

enum { COHSM__TRAY_WORKERS = 8 };

typedef struct cohsm__tray_maker {
    const cohsm_maps *maps;
    uint32_t groups, buckets, columns;
    uint32_t first;                     /* the column of the first worker; the others follow */
    int      writing;
    cohsm__tray_work *work;
    uint32_t *lines;                    /* of each column: first their number, then that of its first one */
    size_t    line_count;               /* of all columns */
    uint8_t  *to;                       /* where line 0 is written */
    uint32_t *base;
    uint16_t *at;
} cohsm__tray_maker;

/* Counts the lines of a column or, the second time, writes them. */
static void cohsm__column_trays(const cohsm__tray_maker *k, uint32_t column, cohsm__tray_work *w)
{
    const cohsm_maps *m = k->maps;
    const uint32_t chunk = column / k->groups, group = column % k->groups, pixel = group << COHSM__GROUP_BITS;
    const uint32_t views = cohsm__min_u32(COHSM__CHUNK, m->head.view_count - (chunk << COHSM__CHUNK_BITS));
    const uint32_t pixels = cohsm__min_u32(COHSM__GROUP, m->range - pixel);
    uint32_t p, begin, sum = k->writing ? k->lines[column] : 0u;
    uint32_t lines, before;
    size_t bucket = (size_t)chunk * (COHSM__CHUNK / COHSM__BUCKET);

    for (p = 0; p < pixels; p++)
        cohsm__cursor_start(&w->cursor[p], m, m->lookup[(size_t)chunk * m->range + pixel + p], views);
    for (begin = 0; begin < views; begin += COHSM__BUCKET, bucket++) {
        cohsm__bucket_trays(w, m, pixels, begin, views);
        lines = cohsm__bucket_place(w, pixels, &before);
        if (k->writing) {
            uint8_t *to = k->to + (size_t)sum * COHSM__LINE_BYTES;
            memset(to, 0, (size_t)lines * COHSM__LINE_BYTES);
            cohsm__bucket_write(w, pixels, before, lines, to, k->at + bucket * m->range + pixel);
            k->base[bucket * k->groups + group] = sum;
        }
        sum += lines;
    }
    if (!k->writing) k->lines[column] = sum;
}

static void cohsm__column_task(void *context, size_t index)
{
    const cohsm__tray_maker *k = (const cohsm__tray_maker *)context;
    const uint32_t column = k->first + (uint32_t)index;

    if (column < k->columns) cohsm__column_trays(k, column, k->work + index);
}

/* The layout that is wanted, and the system that runs the tasks. */
typedef struct cohsm__wish {
    cohsm_layout layout;
    size_t       bytes;                 /* of COHSM_LAYOUT_BUDGET */
    const cohsm_system *system;         /* may be NULL */
} cohsm__wish;

static cohsm_result cohsm__run_columns(cohsm__tray_maker *k, const cohsm__wish *wish, uint32_t workers,
                                       cohsm__part part)
{
    for (k->first = 0; k->first < k->columns; k->first += workers) {
        if (cohsm__cancelled(&part, k->first, k->columns, 1)) return COHSM_ERR_CANCELLED;
        if (workers > 1) wish->system->parallel_for(wish->system->user, workers, cohsm__column_task, k);
        else cohsm__column_task(k, 0);
    }
    return COHSM_OK;
}

/* Returns the words of the block's first sections, filled up to whole lines. */
static size_t cohsm__trays_head(const cohsm__header *h)
{
    const size_t words = (size_t)COHSM__HEADER_WORDS + h->order_words + h->location_words;
    return (words + COHSM__BLOCK_WORDS - 1u) / COHSM__BLOCK_WORDS * COHSM__BLOCK_WORDS;
}

/* Returns the bytes of all trays, 0 if there are too many, and turns the number of lines of each column into
   the number of its first line. */
static size_t cohsm__trays_bytes(cohsm__tray_maker *k)
{
    size_t pointers, bases, bytes = 4 * cohsm__trays_head(&k->maps->head);
    uint64_t sum = 0;
    uint32_t i, lines;

    for (i = 0; i < k->columns; i++) {
        lines = k->lines[i];
        k->lines[i] = (uint32_t)sum;
        sum += lines;
        if (sum > 0xffffffffu) return 0;
    }
    if (sum > (SIZE_MAX - bytes) / COHSM__LINE_BYTES - 2u) return 0;
    k->line_count = (size_t)sum;
    bytes += ((size_t)sum + 2u) * COHSM__LINE_BYTES;    /* 2: to begin and to end with a whole line */
    if (!cohsm__mul_size(k->buckets, k->maps->range, &pointers) || !cohsm__mul_size(pointers, 2, &pointers) ||
        !cohsm__mul_size(k->buckets, 4 * (size_t)k->groups, &bases) ||
        !cohsm__add_size(bytes, pointers, &bytes) || !cohsm__add_size(bytes, bases, &bytes))
        return 0;
    return bytes;
}

/* Writes what stands before the lines: the block's first sections, with a header that says what follows. All
   that is what a GPU needs in place of the block, unless it is longer than a block may be. */
static void cohsm__trays_begin(const cohsm__tray_maker *k, uint32_t *words, cohsm__trays *trays)
{
    const size_t pointers = (size_t)k->buckets * k->maps->range, bases = (size_t)k->buckets * k->groups;
    const size_t lines = COHSM__BLOCK_WORDS * k->line_count, first = cohsm__trays_head(&k->maps->head);
    const uint64_t end = (uint64_t)first + lines + bases + (pointers + 1u) / 2u;
    const uint64_t whole = (end + COHSM__BLOCK_WORDS - 1u) / COHSM__BLOCK_WORDS * COHSM__BLOCK_WORDS;
    cohsm__header h = k->maps->head;

    memset(words, 0, 4 * first);
    memcpy(words, k->maps->words, 4 * ((size_t)COHSM__HEADER_WORDS + h.order_words + h.location_words));
    if (whole > COHSM__MOST_WORDS) return;
    h.magic = COHSM__FAST_MAGIC;
    h.words = (uint32_t)whole;
    h.crc = 0;
    h.self_only |= COHSM__FAST_FLAG;
    h.lookup_words = (uint32_t)lines;
    h.directory_words = (uint32_t)bases;
    h.line_words = (uint32_t)((pointers + 1u) / 2u);
    memcpy(words, &h, sizeof h);
    memset(words + (end - 1u), 0, 4 * (size_t)(whole - end + 1u));
    trays->data = words;
    trays->data_bytes = 4 * (size_t)whole;
}

/* Takes memory for the trays, whose lines were counted, and makes them there. */
static cohsm_result cohsm__trays_fill(cohsm__tray_maker *k, const cohsm__wish *wish, uint32_t workers,
                                      cohsm__part part, cohsm__trays *trays)
{
    uint32_t *words;
    cohsm_result result;

    trays->memory = cohsm__alloc(&k->maps->allocator, trays->bytes);
    if (!trays->memory) return COHSM_ERR_ALLOC;
    words = (uint32_t *)(void *)((uint8_t *)trays->memory + COHSM__LINE_BYTES -
                                 (uintptr_t)trays->memory % COHSM__LINE_BYTES);
    cohsm__trays_begin(k, words, trays);
    words += cohsm__trays_head(&k->maps->head);
    k->to = (uint8_t *)words;
    k->base = words + COHSM__BLOCK_WORDS * k->line_count;
    k->at = (uint16_t *)(void *)(k->base + (size_t)k->buckets * k->groups);
    k->writing = 1;
    result = cohsm__run_columns(k, wish, workers, part);
    if (result != COHSM_OK) {
        cohsm__free(&k->maps->allocator, trays->memory);
        return result;
    }
    trays->lines = k->to;
    trays->base = k->base;
    trays->at = k->at;
    trays->groups = k->groups;
    return COHSM_OK;
}

#ifdef COHSM_WITHOUT_FAST
/* Gives maps the log that they keep; their layout is compact in this header. */
static cohsm_result cohsm__lay_out(cohsm_maps *m, const cohsm__wish *wish, cohsm__part part, size_t *peak)
{
    (void)part;
    *peak = 0;
    if (wish->system) {
        m->log = wish->system->log;
        m->log_user = wish->system->user;
    }
    return COHSM_OK;
}
#else
/* Gives maps the layout that is wanted, and the log that they keep; if this fails, their layout stays
   compact. *peak receives the most bytes that were asked for at once, the trays included. */
static cohsm_result cohsm__lay_out(cohsm_maps *m, const cohsm__wish *wish, cohsm__part part, size_t *peak)
{
    const uint32_t workers = wish->system && wish->system->parallel_for ? (uint32_t)COHSM__TRAY_WORKERS : 1u;
    const size_t most = wish->layout == COHSM_LAYOUT_BUDGET ? wish->bytes : SIZE_MAX;
    const size_t block = 4 * (size_t)m->head.words;
    cohsm__trays trays;
    cohsm__tray_maker k;
    cohsm_result result = COHSM_ERR_ALLOC;

    *peak = 0;
    if (wish->system) {
        m->log = wish->system->log;
        m->log_user = wish->system->user;
    }
    if (wish->layout == COHSM_LAYOUT_COMPACT || most < block) return COHSM_OK;
    memset(&trays, 0, sizeof trays);
    memset(&k, 0, sizeof k);
    k.maps = m;
    k.groups = ((m->range - 1u) >> COHSM__GROUP_BITS) + 1u;
    k.buckets = ((m->head.view_count - 1u) >> COHSM__BUCKET_BITS) + 1u;
    k.columns = k.groups * cohsm__chunks(&m->head);
    if ((uint64_t)2 * k.buckets * m->range > most - block) return COHSM_OK;
    k.work = (cohsm__tray_work *)cohsm__alloc_array(&m->allocator, workers, sizeof *k.work);
    k.lines = (uint32_t *)cohsm__alloc_array(&m->allocator, k.columns, sizeof *k.lines);
    if (k.work && k.lines) {
        result = cohsm__run_columns(&k, wish, workers, cohsm__part_of(&part, 0.0f, 0.5f));
        if (result == COHSM_OK) trays.bytes = cohsm__trays_bytes(&k);
        if (result == COHSM_OK && !trays.bytes) result = COHSM_ERR_LIMIT;
        if (result == COHSM_ERR_LIMIT && most < SIZE_MAX) result = COHSM_OK;
        if (result == COHSM_OK && trays.bytes && trays.bytes <= most - block) {
            *peak = trays.bytes + workers * sizeof *k.work + k.columns * sizeof *k.lines;
            result = cohsm__trays_fill(&k, wish, workers, cohsm__part_of(&part, 0.5f, 1.0f), &trays);
            if (result == COHSM_OK) m->trays = trays;
        }
    }
    cohsm__free(&m->allocator, k.lines);
    cohsm__free(&m->allocator, k.work);
    return result;
}
#endif

/* Logs that trays are refused, if that is what the result of laying maps out says. */
static void cohsm__log_layout(const cohsm__logger *log, const char *field, cohsm_result result)
{
    if (result == COHSM_ERR_LIMIT) cohsm__log_text(log, field, "asks for 256 GiB or more of trays");
}

/* Gives maps that were opened or merged their layout and hands them out, or frees them. */
static cohsm_result cohsm__lay_out_opened(cohsm_maps *maps, const cohsm__wish *wish, cohsm__part part,
                                          cohsm_maps **out)
{
    size_t peak;
    cohsm_result result = cohsm__lay_out(maps, wish, part, &peak);

    if (result == COHSM_OK) *out = maps;
    else cohsm_free(maps);
    return result;
}
