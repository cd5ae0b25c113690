/* ---- open: blocks of files, which may be hostile ---- */

static int cohsm__header_sound(const cohsm__header *h)
{
    cohsm_domain_kind kind = (cohsm_domain_kind)h->domain;
    uint64_t n = (uint64_t)h->side[0] * h->side[1], total;
    uint32_t order;
    size_t i;

    if (h->domain == 0 || h->domain >= COHSM_DOMAIN_COUNT || h->layers == 0 ||
        h->layers >= COHSM_LAYERS_COUNT || h->order == 0 || h->order >= COHSM_ORDER_COUNT ||
        h->orientation == 0 || h->orientation >= COHSM_ORIENTATION_COUNT)
        return 0;
    for (i = 0; i < 3; i++)
        if (h->side[i] == 0 || h->side[i] > (cohsm__has_table(h->domain) ? 1u << 24 : 4096u)) return 0;
    if (n > 1u << 24 || n * h->side[2] > 1u << 24 || n * h->side[2] != h->map_count) return 0;
    if (h->positional > 1 || h->self_only > 1 || h->view_count != h->map_count * (h->positional ? 6u : 1u))
        return 0;
    if (kind == COHSM_DOMAIN_LATLONG || kind == COHSM_DOMAIN_OCTAHEDRAL) {
        if (h->positional || h->side[2] != 1) return 0;
    } else if (!cohsm__has_table(h->domain) && !h->positional) return 0;
    if (h->dimensions != cohsm__dimensions(kind, h->side)) return 0;
    if (h->map_side < 4 || h->map_side > 1024 || h->depth_bits < 4 || h->depth_bits > 8) return 0;
    if (h->pixel_begin >= h->pixel_end || h->pixel_end > h->map_side * h->map_side) return 0;
    order = h->order != COHSM_ORDER_HILBERT ? 0
            : h->map_count <= 65536         ? (h->map_count + 1) / 2
                                            : h->map_count;
    if (h->order_words != order || h->location_words != (cohsm__has_table(h->domain) ? 4 * h->map_count : 0))
        return 0;
    total = (uint64_t)(h->pixel_end - h->pixel_begin) * cohsm__chunks(h);
    if (total != h->lookup_words || h->line_words % COHSM__BLOCK_WORDS != COHSM__PADDING) return 0;
    total += (uint64_t)COHSM__HEADER_WORDS + order + h->location_words + h->directory_words;
    if (total % COHSM__BLOCK_WORDS) return 0;
    total += h->line_words;
    if (total != h->words || total > COHSM__MOST_WORDS) return 0;
    if (!cohsm__floats_finite(h) || !(h->open_thickness > 0.0f && h->open_thickness <= 1024.0f)) return 0;
    if (!cohsm__radius_usable(h->radius) || (h->positional && !(h->depth_far > 0.0f))) return 0;
    for (i = 0; i < sizeof h->reserved / sizeof h->reserved[0]; i++)
        if (h->reserved[i]) return 0;
    return 1;
}

/* Says whether a block is sound within the words that are left of its line: its parts lie inside it, and its
   segments rise and stay below `views`, counted from the block's first view. */
static int cohsm__block_sound(const uint32_t *block, uint32_t left, uint32_t views)
{
    uint32_t n, exact = 0, j, at;
    uint32_t bucket = 0, low, offset, previous = 0;
    uint32_t size, code;
    uint64_t marks;
    cohsm__fields f;

    if (left < 3) return 0;
    marks = cohsm__marks(block);
    n = cohsm__popcount(marks);
    f = cohsm__block_fields(block, n);
    if (!(marks & 1u) || f.bits == 0 || f.exact_at > COHSM__BLOCK_BITS || (f.exact_at + 31u) / 32u > left)
        return 0;
    if ((block[0] >> 12 & 15u) > COHSM__WIDEST && f.palette == 0) return 0;
    for (j = 0; j < n; j++) {
        code = cohsm__bits(block, f.codes_at + j * f.bits, f.bits);
        if (code + 1u == 1u << f.bits) exact++;
        else if (f.palette ? code >= f.palette : code + 2u < 1u << f.bits && (block[0] & 255u) + code > 254u)
            return 0;
    }
    size = f.exact_at + 16u * exact;
    if (size > COHSM__BLOCK_BITS || (size + 31u) / 32u > left) return 0;
    for (at = 0, j = 0; j < n; at++) {
        if (!(marks >> at & 1u)) {
            bucket++;
            continue;
        }
        low = cohsm__bits(block, COHSM__LOW_AT + j * f.k, f.k);
        offset = (bucket << f.k) + low;
        if (j == 0 ? offset != 0 : offset <= previous) return 0;
        previous = offset;
        j++;
    }
    if (previous >= views) return 0;
    /* Every bucket that a search may ask for must have its mark. */
    return ((views - 1u) >> f.k) + n <= COHSM__MARKS;
}

/* Says whether the list of an entry is sound. *unnamed counts the words of directories that no entry before
   has named, and is reduced by those of this list. Lists share no words, so all checks together take time
   that is linear in the file, even if all entries name the longest list. */
static int cohsm__list_sound(const cohsm_maps *m, uint32_t entry, uint32_t views, uint32_t *unnamed)
{
    const uint32_t *directory = m->directories + entry;
    uint32_t lines = m->head.line_words / COHSM__BLOCK_WORDS;
    uint32_t left = m->head.directory_words - entry, blocks, tail, b;
    uint32_t first = 0, next;

    if (left < 2) return 0;
    blocks = cohsm__block_count(directory);
    tail = directory[1] >> 16;
    if (blocks == 0 || 2u + blocks / 2u > cohsm__min_u32(left, *unnamed)) return 0;
    *unnamed -= 2u + blocks / 2u;
    if (directory[0] > lines || blocks - 1u > lines - directory[0]) return 0;
    if (tail >> 4 > directory[0] || directory[0] - (tail >> 4) >= lines) return 0;
    for (b = 0; b < blocks; b++) {
        next = b + 1 < blocks ? cohsm__block_first(directory, b + 1) : views;
        if (next <= first || next > views) return 0;
        if (!cohsm__block_sound(cohsm__block_at(directory, m->lines, b),
                                b + 1 < blocks ? (uint32_t)COHSM__BLOCK_WORDS
                                               : COHSM__BLOCK_WORDS - (tail & 15u),
                                next - first))
            return 0;
        first = next;
    }
    return 1;
}

static cohsm_result cohsm__check_lists(const cohsm_maps *m, cohsm__part part)
{
    uint32_t entry, views, chunk, chunks = cohsm__chunks(&m->head);
    uint32_t unnamed = m->head.directory_words;
    size_t i;

    for (i = 0; i < m->head.lookup_words; i++) {
        if (cohsm__cancelled(&part, i, m->head.lookup_words, COHSM__LISTS_COPIED)) return COHSM_ERR_CANCELLED;
        chunk = (uint32_t)(i / m->range);
        views = chunk + 1 < chunks ? COHSM__CHUNK : m->head.view_count - chunk * COHSM__CHUNK;
        entry = m->lookup[i];
        if (entry & COHSM__CONSTANT ? entry & 0x7fff0000u
                                    : entry >= m->head.directory_words ||
                                          !cohsm__list_sound(m, entry, views, &unnamed))
            return COHSM_ERR_FORMAT;
    }
    return COHSM_OK;
}

static int cohsm__tables_sound(const cohsm_maps *m)
{
    uint32_t i, n = m->head.map_count;
    const float *l = m->locations;

    for (i = 0; m->head.order_words && i < n; i++)
        if ((n <= 65536 ? cohsm__half_word(m->order, i) : m->order[i]) >= n) return 0;
    for (i = 0; m->head.location_words && i < n; i++, l += 4)
        if (!cohsm__v3_finite(cohsm__v3_load(l)) || l[3] != (m->head.positional ? 1.0f : 0.0f)) return 0;
    return 1;
}

/* Makes maps of a block of a file after checking everything in it. Takes the memory over, or frees it if this
   fails. */
static cohsm_result cohsm__open_block(const cohsm__allocator *a, cohsm__part part, cohsm__memory block,
                                      cohsm_maps **out)
{
    cohsm_maps *m;
    cohsm_result result = cohsm__maps_make(a, block, &m);

    if (result != COHSM_OK) return result;
    result = cohsm__tables_sound(m) ? cohsm__check_lists(m, part) : COHSM_ERR_FORMAT;
    if (result == COHSM_OK) *out = m;
    else cohsm_free(m);
    return result;
}

static cohsm_result cohsm__open_plain(const uint8_t *data, size_t size, const cohsm__allocator *a,
                                      const cohsm__part *part, cohsm_maps **out)
{
    cohsm__header h;
    cohsm__memory block;

    if (size < sizeof h) return COHSM_ERR_FORMAT;
    memcpy(&h, data, sizeof h);
    cohsm__host_words((uint32_t *)(void *)&h, COHSM__HEADER_WORDS);
    if (!cohsm__header_sound(&h) || size != 4 * (size_t)h.words) return COHSM_ERR_FORMAT;
    block = cohsm__take_block(a, h.words);
    if (!block.words) return COHSM_ERR_ALLOC;
    memcpy(block.words, data, size);
    cohsm__host_words(block.words, h.words);
    if (cohsm__block_crc(block.words, h.words) != h.crc) {
        cohsm__free(a, block.memory);
        return COHSM_ERR_FORMAT;
    }
    return cohsm__open_block(a, *part, block, out);
}
