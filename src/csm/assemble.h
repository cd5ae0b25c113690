/* ---- block: the finished maps ---- */

static void cohsm__host_words(uint32_t *words, size_t count)
{
    size_t i;
    if (cohsm__host_is_little_endian()) return;
    for (i = 0; i < count; i++) words[i] = cohsm__get_u32((const uint8_t *)(words + i));
}

static void cohsm__crc_words(const uint32_t *words, size_t count, uint32_t *crc)
{
    uint8_t bytes[256];
    size_t i, n;
    if (cohsm__host_is_little_endian()) {
        *crc = cohsm__crc32(*crc, words, 4 * count);
        return;
    }
    for (; count; count -= n, words += n) {
        n = count < 64 ? count : 64;
        for (i = 0; i < n; i++) cohsm__put_u32(bytes + 4 * i, words[i]);
        *crc = cohsm__crc32(*crc, bytes, 4 * n);
    }
}

static uint32_t cohsm__block_crc(const uint32_t *words, size_t count)
{
    uint32_t crc = 0;
    cohsm__crc_words(words + 4, count - 4, &crc);
    return crc;
}

static void cohsm__dop_in_radii(cohsm_maps *m)
{
    int i;
    for (i = 0; i < 2 * COHSM__DOP_AXES; i++)
        m->dop[i] = (m->head.dop[i] - cohsm__v3_dot(cohsm__dop_axis(i / 2), cohsm__v3_load(m->head.center))) /
                    m->head.radius;
}

/* Finds the sections of a block whose header is sound, and makes the tables that queries read. */
static void cohsm__find_sections(cohsm_maps *m)
{
    const uint32_t *at = m->words + COHSM__HEADER_WORDS;
    uint32_t i, grid = (1u << m->head.depth_bits) - 1u;

    m->order = at;
    at += m->head.order_words;
    m->locations = (const float *)(const void *)at;
    at += m->head.location_words;
    m->lookup = at;
    at += m->head.lookup_words;
    m->directories = at;
    at += m->head.directory_words;
    m->lines = at;
    m->range = m->head.pixel_end - m->head.pixel_begin;
    for (i = 0; i < 512; i++)
        m->depth_of[i] = (uint16_t)(i < grid ? i * 65535u / grid : (uint32_t)COHSM__INFINITE);
    cohsm__dop_in_radii(m);
    m->simd = cohsm__simd();
    if (m->angles) cohsm__latlong_angles(m->head.side, m->angles);
}

/* A block in memory of the caller's allocator, which promises alignment to 8 bytes only: the words begin at
   the next boundary of a cache line. */
typedef struct cohsm__memory { void *memory; uint32_t *words; } cohsm__memory;

static cohsm__memory cohsm__take_block(const cohsm__allocator *a, uint32_t words)
{
    cohsm__memory b;
    size_t size;

    b.memory = b.words = NULL;
    /* The sum may overflow on 32-bit targets. */
    if (!cohsm__mul_size(words, 4, &size) || !cohsm__add_size(size, 64, &size)) return b;
    b.memory = cohsm__alloc(a, size);
    if (!b.memory) return b;
    b.words = (uint32_t *)(void *)((char *)b.memory + (64u - (uintptr_t)b.memory % 64u));
    memset(b.words, 0, 4 * (size_t)words);
    return b;
}

/* Makes maps of a block in host order whose header is sound. Takes the memory over, or frees it if this
   fails. */
static cohsm_result cohsm__maps_make(const cohsm__allocator *a, cohsm__memory block, cohsm_maps **out)
{
    cohsm_maps *m = (cohsm_maps *)cohsm__alloc(a, sizeof *m);
    if (m) {
        memset(m, 0, sizeof *m);
        m->allocator = *a;
        m->memory = block.memory;
        m->words = block.words;
        memcpy(&m->head, block.words, sizeof m->head);
        if (m->head.domain == COHSM_DOMAIN_LATLONG) {
            m->angles = (float *)cohsm__alloc_array(a, 2 * ((size_t)m->head.side[0] + m->head.side[1]),
                                                    sizeof(float));
            if (!m->angles) {
                cohsm__free(a, m);
                m = NULL;
            }
        }
    }
    if (!m) {
        cohsm__free(a, block.memory);
        return COHSM_ERR_ALLOC;
    }
    cohsm__find_sections(m);
    *out = m;
    return COHSM_OK;
}

COHSM_DEF void cohsm_free(cohsm_maps *maps)
{
    cohsm__allocator a;
    if (!maps) return;
    a = maps->allocator;
    cohsm__free(&a, maps->trays.memory);
    cohsm__free(&a, maps->angles);
    cohsm__free(&a, maps->memory);
    cohsm__free(&a, maps);
}

static void cohsm__write_order(uint32_t *words, const uint32_t *cells, uint32_t count)
{
    uint32_t i;
    for (i = 0; i < count; i++)
        if (count <= 65536) cohsm__put_bits(words, 16 * cells[i], 16, i);
        else words[cells[i]] = i;
}

/* Lays out all lists of a builder. lookup says where each list begins in its piece; the call replaces that by
   where the list's directory is. */
static void cohsm__lay_builder(const cohsm_builder *b, cohsm__layout *l, uint32_t *lookup)
{
    const cohsm__words *piece = b->lists;
    uint32_t c, i, p, chunks = cohsm__chunks(&b->head);

    for (c = 0; c < chunks; c++, lookup += b->range_pixels)
        for (i = 0; i < COHSM__RANGES; i++) {
            const cohsm__range *r = &b->ranges[i];
            if (r->begin == r->end) continue;
            for (p = r->begin; p < r->end; p++)
                if (!(lookup[p] & COHSM__CONSTANT)) cohsm__lay_raw(l, lookup + p, piece->data + lookup[p]);
            piece = piece->next;
        }
}

/* Sets the lengths of the last sections from a dry run of the layout. */
static cohsm_result cohsm__size_block(cohsm__header *h, const cohsm__layout *l)
{
    uint64_t before = (uint64_t)COHSM__HEADER_WORDS + h->order_words + h->location_words + h->lookup_words;
    uint64_t directories = l->directory_words, lines = COHSM__BLOCK_WORDS * l->line_count + COHSM__PADDING;
    directories += (0u - (before + directories)) % COHSM__BLOCK_WORDS;
    if (before + directories + lines > COHSM__MOST_WORDS) return COHSM_ERR_LIMIT;
    h->directory_words = (uint32_t)directories;
    h->line_words = (uint32_t)lines;
    h->words = (uint32_t)(before + directories + lines);
    return COHSM_OK;
}

static void cohsm__layout_into(cohsm__layout *l, const cohsm__header *h, uint32_t *words, uint32_t **lookup)
{
    memset(l, 0, sizeof *l);
    *lookup = words + COHSM__HEADER_WORDS + h->order_words + h->location_words;
    l->directories = *lookup + h->lookup_words;
    l->lines = l->directories + h->directory_words;
}

static void cohsm__seal_block(uint32_t *words, const cohsm__header *h)
{
    memcpy(words, h, sizeof *h);
    words[3] = cohsm__block_crc(words, h->words);
}

/* Writes the block of a builder into words, which are zeroed and as many as the header says. */
static void cohsm__assemble(const cohsm_builder *b, uint32_t *words)
{
    const cohsm__header *h = &b->head;
    cohsm__layout layout;
    uint32_t *lookup;

    cohsm__layout_into(&layout, h, words, &lookup);
    if (h->order_words) cohsm__write_order(words + COHSM__HEADER_WORDS, b->cells, h->map_count);
    if (h->location_words)
        memcpy(words + COHSM__HEADER_WORDS + h->order_words, b->locations, 4 * (size_t)h->location_words);
    memcpy(lookup, b->lookup, 4 * (size_t)h->lookup_words);
    cohsm__lay_builder(b, &layout, lookup);
    cohsm__seal_block(words, h);
}

static void cohsm__sum_stats(const cohsm_builder *b, cohsm_stats *s)
{
    int i;
    for (i = 0; i < COHSM__RANGES; i++) {
        s->segments += b->ranges[i].segments;
        s->exact_depths += b->ranges[i].exact;
        s->empty_intervals += b->ranges[i].empty;
        s->open_entries += b->ranges[i].open;
    }
    s->order = (cohsm_order)b->head.order;
    s->peak_bytes = b->heap.peak;
}

/* Returns the bytes that maps with this header take in the compact layout. */
static size_t cohsm__maps_bytes(const cohsm__header *h)
{
    return 4 * (size_t)h->words + 64 + sizeof(cohsm_maps) +
           8 * ((size_t)h->side[0] + h->side[1]) * (h->domain == COHSM_DOMAIN_LATLONG);
}

/* Makes the maps of a builder, and fills in every field of stats but those of the mesh. */
static cohsm_result cohsm__finish_maps(cohsm_builder *b, cohsm_maps **out, cohsm_stats *stats)
{
    cohsm__header *h = &b->head;
    cohsm__layout dry;
    cohsm__memory block;
    cohsm_result result;

    memset(&dry, 0, sizeof dry);
    cohsm__sum_stats(b, stats);
    h->lookup_words = b->range_pixels * cohsm__chunks(h);
    h->segments_low = (uint32_t)(stats->segments & 0xffffffffu);
    h->segments_high = (uint32_t)(stats->segments >> 32);
    cohsm__lay_builder(b, &dry, b->lookup);
    result = cohsm__size_block(h, &dry);
    if (result != COHSM_OK) return result;
    stats->peak_bytes = b->heap.used + cohsm__maps_bytes(h);
    if (stats->peak_bytes < b->heap.peak) stats->peak_bytes = b->heap.peak;
    block = cohsm__take_block(&b->heap.allocator, h->words);
    if (!block.words) return COHSM_ERR_ALLOC;
    cohsm__assemble(b, block.words);
    return cohsm__maps_make(&b->heap.allocator, block, out);
}

#ifndef COHSM_WITHOUT_BUILD
/* Gives finished maps the layout of their desc; if this fails, frees them and logs why. `held` is how many
   bytes the builder still has. */
static cohsm_result cohsm__lay_out_built(cohsm_maps **maps, const cohsm_desc *d, size_t held,
                                         cohsm_stats *stats, const cohsm__logger *log)
{
    const cohsm__header *h = &(*maps)->head;
    cohsm__part whole;
    cohsm__wish wish;
    cohsm_result result;
    size_t peak;

    wish.layout = d->layout;
    wish.bytes = d->layout_bytes;
    wish.system = &d->system;
    memset(&whole, 0, sizeof whole);            /* the build has told its progress */
    result = cohsm__lay_out(*maps, &wish, whole, &peak);
    if (peak) peak += held + cohsm__maps_bytes(h);
    if (stats->peak_bytes < peak) stats->peak_bytes = peak;
    if (result != COHSM_OK) cohsm_free(*maps);
    cohsm__log_layout(log, "desc.layout", result);
    return cohsm__log_result(log, result);
}

COHSM_DEF cohsm_result cohsm_builder_finish(cohsm_builder *b, cohsm_maps **out, cohsm_stats *stats)
{
    cohsm_maps *maps = NULL;
    cohsm_stats s;
    cohsm_result result;
    cohsm__logger log;

    if (!b) return COHSM_ERR_ARGUMENT;
    log = cohsm__logger_of(&b->desc.system, "cohsm_builder_finish");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (b->finished)
        return cohsm__refuse(&log, COHSM_ERR_ORDER, "the builder", "has ended, or failed before");
    if (b->next_view != b->head.view_count || b->batch_count) {
        cohsm__log_value(&log, "the number of views that were added",
                         (double)(b->batch_begin + b->batch_count), "cohsm_builder_view_count(builder)");
        return COHSM_ERR_ORDER;
    }
    memset(&s, 0, sizeof s);
    result = cohsm__finish_maps(b, &maps, &s);
    if (result != COHSM_OK) return cohsm__log_build(&log, &b->desc, result);
    result = cohsm__lay_out_built(&maps, &b->desc, b->heap.used, &s, &log);
    if (result != COHSM_OK) return result;
    *out = maps;
    b->finished = 1;
    if (stats) *stats = s;
    return COHSM_OK;
}
#endif
