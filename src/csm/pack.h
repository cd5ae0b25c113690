/* ---- pack: maps to packed files, and back ---- */

/* Codes all lists of a block. The decoder writes the lists and the lookup into out, which is words with its
   header. Returns COHSM_ERR_FORMAT if no builder wrote this, or if there is no room for it. */
static cohsm_result cohsm__code_lists(cohsm__packer *p, const cohsm__header *h, const uint32_t *words,
                                      uint32_t *out, cohsm__part part)
{
    cohsm__lists lists = cohsm__lists_of(h, words);
    cohsm__layout layout;
    uint32_t range = h->pixel_end - h->pixel_begin, pixel, blocks, *lookup = NULL;
    size_t i;

    if (out) cohsm__layout_into(&layout, h, out, &lookup);
    for (i = 0; i < h->lookup_words; i++) {
        if (cohsm__cancelled(&part, i, h->lookup_words, COHSM__LISTS_CODED)) return COHSM_ERR_CANCELLED;
        pixel = (uint32_t)(i % range);
        if (pixel == 0) {
            p->views = cohsm__min_u32(h->view_count - (uint32_t)(i / range) * COHSM__CHUNK, COHSM__CHUNK);
            p->width = (COHSM__MARGIN + p->views + COHSM__REACH) / 32u + 2u;
        }
        cohsm__look_around(p, h, pixel, i, &lists);
        if (!out) cohsm__strip_read(p, &p->strip[COHSM__SELF], &lists, i, p->taken);
        cohsm__code_breaks(p);
        cohsm__code_values(p);
        blocks = cohsm__code_blocks(p);
        if (p->bad || p->c.full) return COHSM_ERR_FORMAT;
        if (out && !cohsm__strip_lay(p, h, blocks, &layout, &lookup[i])) return COHSM_ERR_FORMAT;
    }
    return COHSM_OK;
}

/* Returns how many segments the longest list has. */
static uint32_t cohsm__longest_list(const cohsm_maps *m)
{
    uint32_t longest = 1, n, b;
    size_t i;
    for (i = 0; i < m->head.lookup_words; i++) {
        const uint32_t *directory = m->directories + m->lookup[i];
        if (m->lookup[i] & COHSM__CONSTANT) continue;
        for (b = 0, n = 0; b < cohsm__block_count(directory); b++)
            n += cohsm__popcount(cohsm__marks(cohsm__block_at(directory, m->lines, b)));
        longest = cohsm__max_u32(longest, n);
    }
    return longest;
}

/* Returns the bytes of memory that the work on a block takes: strips, and the order table's cells. */
static uint64_t cohsm__pack_work(const cohsm__header *h, uint32_t longest)
{
    return (uint64_t)longest * (COHSM__STRIPS * sizeof(cohsm__segment) + 1) +
           4 * (uint64_t)cohsm__list_bound(longest) + (h->order_words ? 4 * (uint64_t)h->map_count : 0);
}

static int cohsm__packer_make(cohsm__packer *p, const cohsm__allocator *a, const cohsm__header *h,
                              uint32_t longest)
{
    cohsm__prob *probs;
    size_t i;

    memset(p, 0, sizeof *p);
    p->longest = longest;
    p->grid = cohsm__grid_of(h->depth_bits, h->map_side);
    p->m = (cohsm__odds *)cohsm__alloc(a, sizeof *p->m);
    p->segments =
        (cohsm__segment *)cohsm__alloc_array(a, longest, COHSM__STRIPS * sizeof(cohsm__segment) + 1);
    p->list = (uint32_t *)cohsm__alloc_array(a, cohsm__list_bound(longest), 4);
    if (!p->m || !p->segments || !p->list) return 0;
    memset(p->m->breaks, 0, sizeof p->m->breaks);
    probs = p->m->hot;
    for (i = 0; i < offsetof(cohsm__odds, breaks) / sizeof *probs; i++) probs[i] = 0x8000u;
    for (i = 0; i < COHSM__STRIPS; i++) {
        p->strip[i].breaks = p->m->breaks[i];
        p->strip[i].s = p->segments + i * longest;
    }
    p->taken = (uint8_t *)(p->segments + COHSM__STRIPS * (size_t)longest);
    return 1;
}

static void cohsm__packer_free(cohsm__packer *p, const cohsm__allocator *a)
{
    cohsm__free(a, p->m);
    cohsm__free(a, p->segments);
    cohsm__free(a, p->list);
}

static size_t cohsm__pack_head(const cohsm__header *h)
{
    return COHSM__PACK_HEADER + 4 * ((size_t)COHSM__HEADER_WORDS + h->location_words);
}

/* Puts the words that are not coded in their places, and makes the order table. */
static cohsm_result cohsm__unpack_head(const uint8_t *data, const cohsm__allocator *a, const cohsm__header *h,
                                       uint32_t *words)
{
    size_t i, gap = COHSM__HEADER_WORDS + (size_t)h->order_words;
    uint32_t *cells;

    data += COHSM__PACK_HEADER;
    for (i = 0; i < COHSM__HEADER_WORDS; i++) words[i] = cohsm__get_u32(data + 4 * i);
    data += 4 * (size_t)COHSM__HEADER_WORDS;
    for (i = 0; i < h->location_words; i++) words[gap + i] = cohsm__get_u32(data + 4 * i);
    if (!h->order_words) return COHSM_OK;
    cells = (uint32_t *)cohsm__alloc_array(a, h->map_count, 4);
    if (!cells) return COHSM_ERR_ALLOC;
    cohsm__order_cells(cells, h->side, (cohsm_order)h->order);
    cohsm__write_order(words + COHSM__HEADER_WORDS, cells, h->map_count);
    cohsm__free(a, cells);
    return COHSM_OK;
}

static cohsm_result cohsm__unpack_words(const uint8_t *data, size_t size, const cohsm__allocator *a,
                                        cohsm__part part, const cohsm__header *h, uint32_t *words)
{
    cohsm__packer p;
    size_t head = cohsm__pack_head(h);
    cohsm_result result = cohsm__unpack_head(data, a, h, words);

    if (result != COHSM_OK) return result;
    if (!cohsm__packer_make(&p, a, h, cohsm__get_u32(data + 12))) result = COHSM_ERR_ALLOC;
    else {
        cohsm__coder_start(&p.c, NULL, data + head, size - head);
        result = cohsm__code_lists(&p, h, words, words, part);
        if (result == COHSM_OK && cohsm__block_crc(words, h->words) != h->crc) result = COHSM_ERR_FORMAT;
    }
    cohsm__packer_free(&p, a);
    return result;
}

/* Says whether a packed file of so many bytes can have this header, which is sound, and this longest list. */
static int cohsm__packed_sound(const cohsm__header *h, uint32_t longest, size_t size)
{
    return longest <= COHSM__CHUNK && longest <= h->view_count && cohsm__pack_head(h) <= size &&
           4 * (uint64_t)h->words + cohsm__pack_work(h, longest) <= COHSM__PACK_MULTIPLE * (uint64_t)size;
}

/* Unpacks a packed file of 16 bytes or more whose magic is known; all else in it may be hostile. It asks for
   at most COHSM__PACK_MULTIPLE bytes of memory a byte of file, and 256 KB for the probabilities and the
   object. */
static cohsm_result cohsm__unpack(const uint8_t *data, size_t size, const cohsm__allocator *a,
                                  const cohsm__part *part, cohsm_maps **out)
{
    const uint8_t *inner = data + COHSM__PACK_HEADER;
    cohsm__header h;
    cohsm__memory block;
    uint32_t longest;
    cohsm_result result;

    if (cohsm__get_u32(data + 4) != COHSM__PACK_FORMAT) return COHSM_ERR_VERSION;
    if (cohsm__get_u32(data + 8) != size || size < COHSM__PACK_HEADER + sizeof h) return COHSM_ERR_FORMAT;
    if (cohsm__get_u32(inner) != COHSM__MAGIC) return COHSM_ERR_FORMAT;
    if (cohsm__get_u32(inner + 4) != COHSM__FORMAT) return COHSM_ERR_VERSION;
    longest = cohsm__get_u32(data + 12);
    if (longest == 0) return cohsm__open_plain(inner, size - COHSM__PACK_HEADER, a, part, out);
    memcpy(&h, inner, sizeof h);
    cohsm__host_words((uint32_t *)(void *)&h, COHSM__HEADER_WORDS);
    if (!cohsm__header_sound(&h) || !cohsm__packed_sound(&h, longest, size)) return COHSM_ERR_FORMAT;
    block = cohsm__take_block(a, h.words);
    if (!block.words) return COHSM_ERR_ALLOC;
    result = cohsm__unpack_words(data, size, a, cohsm__part_of(part, 0.0f, 0.9f), &h, block.words);
    if (result == COHSM_OK) return cohsm__open_block(a, cohsm__part_of(part, 0.9f, 1.0f), block, out);
    cohsm__free(a, block.memory);
    return result;
}

static void cohsm__pack_begin(uint8_t *data, size_t size, uint32_t longest)
{
    cohsm__put_u32(data, COHSM__PACK_MAGIC);
    cohsm__put_u32(data + 4, COHSM__PACK_FORMAT);
    cohsm__put_u32(data + 8, (uint32_t)size);
    cohsm__put_u32(data + 12, longest);
}

/* Codes maps into data; returns COHSM_ERR_FORMAT if the code would reach room. The file is filled up with
   zeros to the size that opening has to see before it asks for memory. */
static cohsm_result cohsm__pack_coded(cohsm__packer *p, const cohsm_maps *m, const cohsm__part *part,
                                      uint8_t *data, size_t room, size_t *size)
{
    const cohsm__header *h = &m->head;
    size_t head = cohsm__pack_head(h), i, gap = COHSM__HEADER_WORDS + (size_t)h->order_words;
    uint64_t least = 4 * (uint64_t)h->words + cohsm__pack_work(h, p->longest);
    cohsm_result result;

    least = (least + COHSM__PACK_MULTIPLE - 1u) / COHSM__PACK_MULTIPLE;
    if (least >= room) return COHSM_ERR_FORMAT;
    for (i = 0; i < COHSM__HEADER_WORDS; i++) cohsm__put_u32(data + COHSM__PACK_HEADER + 4 * i, m->words[i]);
    for (i = 0; i < h->location_words; i++)
        cohsm__put_u32(data + COHSM__PACK_HEADER + 4 * (COHSM__HEADER_WORDS + i), m->words[gap + i]);
    cohsm__coder_start(&p->c, data + head, NULL, room - head);
    result = cohsm__code_lists(p, h, m->words, NULL, cohsm__part_of(part, 0.0f, 0.5f));
    if (result != COHSM_OK) return result;
    for (i = 0; i < 4; i++) cohsm__coder_byte(&p->c);
    if (p->c.full) return COHSM_ERR_FORMAT;
    *size = head + p->c.at;
    if (*size < least) {
        memset(data + *size, 0, (size_t)least - *size);
        *size = (size_t)least;
    }
    cohsm__pack_begin(data, *size, p->longest);
    return COHSM_OK;
}

/* Returns COHSM_ERR_FORMAT if data does not unpack to these maps: they are sound, but our builder did not
   write them. */
static cohsm_result cohsm__pack_check(const cohsm_maps *m, const cohsm__allocator *a, const cohsm__part *part,
                                      const uint8_t *data, size_t size)
{
    cohsm__part second = cohsm__part_of(part, 0.5f, 1.0f);
    cohsm_maps *copy;
    cohsm_result result = cohsm__unpack(data, size, a, &second, &copy);

    if (result != COHSM_OK) return result;
    if (memcmp(copy->words, m->words, 4 * (size_t)m->head.words) != 0) result = COHSM_ERR_FORMAT;
    cohsm_free(copy);
    return result;
}

COHSM_DEF cohsm_result cohsm_pack(const cohsm_maps *maps, const cohsm_system *system, void **data,
                                  size_t *bytes)
{
    cohsm__allocator a;
    cohsm__part part;
    cohsm__packer p;
    uint8_t *big, *packed = NULL;
    size_t plain, coded = 0;
    uint64_t whole;
    cohsm_result result;
    cohsm__logger log = cohsm__logger_of(system, "cohsm_pack");

    if (!maps) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "maps", "is NULL");
    if (!data) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "data", "is NULL");
    if (!bytes) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "bytes", "is NULL");
    if (!cohsm__services_of(system, &log, &a, &part)) return COHSM_ERR_DESC;
    whole = 4 * (uint64_t)maps->head.words + COHSM__PACK_HEADER;
    if (whole > 0xffffffffu) return cohsm__refuse(&log, COHSM_ERR_LIMIT, "maps", "take 4 GiB or more");
    plain = (size_t)whole;
    big = (uint8_t *)cohsm__alloc(&a, plain);
    if (!big) return cohsm__log_result(&log, COHSM_ERR_ALLOC);
    if (cohsm__packer_make(&p, &a, &maps->head, cohsm__longest_list(maps)))
        result = cohsm__pack_coded(&p, maps, &part, big, plain, &coded);
    else result = COHSM_ERR_ALLOC;
    cohsm__packer_free(&p, &a);
    if (result == COHSM_OK) result = cohsm__pack_check(maps, &a, &part, big, coded);
    if (result == COHSM_ERR_FORMAT) {                   /* as it is */
        coded = plain;
        cohsm__pack_begin(big, plain, 0);
        result = cohsm_write(maps, big + COHSM__PACK_HEADER, plain - COHSM__PACK_HEADER);
    }
    if (result == COHSM_OK) {
        packed = (uint8_t *)cohsm__alloc(&a, coded);
        if (packed) memcpy(packed, big, coded);
        else result = COHSM_ERR_ALLOC;
    }
    cohsm__free(&a, big);
    if (result != COHSM_OK) return cohsm__log_result(&log, result);
    *data = packed;
    *bytes = coded;
    return COHSM_OK;
}
