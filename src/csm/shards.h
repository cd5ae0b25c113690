/* ---- shards: parts of one build, by ranges of pixels, put together ---- */

/* Says whether two shards are of one build: they then differ in their pixels, lengths and counts only. */
static int cohsm__same_build(const cohsm_maps *a, const cohsm_maps *b)
{
    cohsm__header x = a->head, y = b->head;
    size_t before = (size_t)x.order_words + x.location_words;
    x.words = y.words = x.crc = y.crc = 0;
    x.pixel_begin = y.pixel_begin = x.pixel_end = y.pixel_end = 0;
    x.lookup_words = y.lookup_words = x.directory_words = y.directory_words = x.line_words = y.line_words = 0;
    x.segments_low = y.segments_low = x.segments_high = y.segments_high = 0;
    return memcmp(&x, &y, sizeof x) == 0 &&
           memcmp(a->words + COHSM__HEADER_WORDS, b->words + COHSM__HEADER_WORDS, 4 * before) == 0;
}

/* Lays the lists of all shards one after the other. Returns 0 if the caller cancelled. */
static int cohsm__lay_shards(const cohsm_maps *const *shards, size_t count, cohsm__part part,
                             cohsm__layout *l, uint32_t *lookup)
{
    uint32_t chunk, chunks = cohsm__chunks(&shards[0]->head), p, dry_entry;
    size_t i, done = 0, lists = (size_t)shards[count - 1u]->head.pixel_end * chunks;

    for (chunk = 0; chunk < chunks; chunk++)
        for (i = 0; i < count; i++) {
            const cohsm_maps *s = shards[i];
            for (p = 0; p < s->range; p++) {
                uint32_t entry = s->lookup[(size_t)chunk * s->range + p],
                         *at = lookup ? lookup++ : &dry_entry, blocks;
                const uint32_t *directory = s->directories + entry;
                if (cohsm__cancelled(&part, done++, lists, COHSM__LISTS_COPIED)) return 0;
                *at = entry;
                if (entry & COHSM__CONSTANT) continue;
                blocks = cohsm__block_count(directory);
                cohsm__lay_list(l, at, blocks, directory, 3, cohsm__block_at(directory, s->lines, 0),
                                cohsm__block_at(directory, s->lines, blocks - 1u));
            }
        }
    return 1;
}

static cohsm_result cohsm__join_shards(const cohsm_maps *const *shards, size_t count, cohsm__header *h,
                                       const cohsm__allocator *a, const cohsm__part *part, cohsm_maps **out)
{
    cohsm__layout layout;
    cohsm__memory block;
    uint32_t *lookup;
    cohsm_result result;

    memset(&layout, 0, sizeof layout);
    if (!cohsm__lay_shards(shards, count, cohsm__part_of(part, 0.0f, 0.5f), &layout, NULL))
        return COHSM_ERR_CANCELLED;
    result = cohsm__size_block(h, &layout);
    if (result != COHSM_OK) return result;
    block = cohsm__take_block(a, h->words);
    if (!block.words) return COHSM_ERR_ALLOC;
    memcpy(block.words + COHSM__HEADER_WORDS, shards[0]->words + COHSM__HEADER_WORDS,
           4 * ((size_t)h->order_words + h->location_words));
    cohsm__layout_into(&layout, h, block.words, &lookup);
    if (!cohsm__lay_shards(shards, count, cohsm__part_of(part, 0.5f, 1.0f), &layout, lookup)) {
        cohsm__free(a, block.memory);
        return COHSM_ERR_CANCELLED;
    }
    cohsm__seal_block(block.words, h);
    return cohsm__maps_make(a, block, out);
}

COHSM_DEF cohsm_result cohsm_merge(const cohsm_maps *const *shards, size_t count, const cohsm_system *system,
                                   cohsm_maps **out)
{
    cohsm__allocator a;
    cohsm__part part, joined;
    cohsm__wish wish;
    cohsm_maps *maps = NULL;
    cohsm_result result;
    uint64_t segments = 0;
    cohsm__header h;
    uint32_t next = 0;
    size_t i;
    cohsm__logger log = cohsm__logger_of(system, "cohsm_merge");

    if (!shards) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "shards", "is NULL");
    if (!count) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "count", "is 0; it must be 1 or more");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (!cohsm__services_of(system, &log, &a, &part)) return COHSM_ERR_DESC;
    for (i = 0; i < count; i++) {
        if (!shards[i]) {
            cohsm__log_element_text(&log, "shards", i, "is NULL");
            return COHSM_ERR_ARGUMENT;
        }
        if (!cohsm__same_build(shards[0], shards[i]))
            return cohsm__refuse(&log, COHSM_ERR_MISMATCH, "shards", "are not all of one desc and mesh");
        if (shards[i]->head.pixel_begin != next) {
            cohsm__log_element(&log, "shards", i, "begins with pixel", (double)shards[i]->head.pixel_begin,
                               "where the shard before ends, 0 for the first");
            return COHSM_ERR_MISMATCH;
        }
        next = shards[i]->head.pixel_end;
        segments += (uint64_t)shards[i]->head.segments_high << 32 | shards[i]->head.segments_low;
    }
    h = shards[0]->head;
    if (next != h.map_side * h.map_side) {
        cohsm__log_element(&log, "shards", count - 1, "ends at pixel", (double)next,
                           "map_side^2 for the last");
        return COHSM_ERR_MISMATCH;
    }
    h.pixel_end = next;
    h.lookup_words = next * cohsm__chunks(&h);
    h.segments_low = (uint32_t)(segments & 0xffffffffu);
    h.segments_high = (uint32_t)(segments >> 32);
    wish.layout = shards[0]->trays.lines ? COHSM_LAYOUT_FAST : COHSM_LAYOUT_COMPACT;
    wish.bytes = 0;
    wish.system = system;
    joined = cohsm__part_of(&part, 0.0f, wish.layout == COHSM_LAYOUT_FAST ? 0.5f : 1.0f);
    result = cohsm__join_shards(shards, count, &h, &a, &joined, &maps);
    part = cohsm__part_of(&part, 0.5f, 1.0f);
    if (result == COHSM_ERR_LIMIT) cohsm__log_text(&log, "shards", "make maps of 4 GiB or more together");
    if (result == COHSM_OK) {
        result = cohsm__lay_out_opened(maps, &wish, part, out);
        cohsm__log_layout(&log, "the layout of shards[0]", result);
    }
    return cohsm__log_result(&log, result);
}
