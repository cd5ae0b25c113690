/* ---- files: the block as bytes, and back ---- */

COHSM_DEF const void *cohsm_data(const cohsm_maps *m, size_t *bytes)
{
    if (!m) return NULL;
    if (bytes) *bytes = 4 * (size_t)m->head.words;
    return m->words;
}

COHSM_DEF const void *cohsm_fast_data(const cohsm_maps *m, size_t *bytes)
{
    if (bytes) *bytes = m ? m->trays.data_bytes : 0;
    return m ? m->trays.data : NULL;
}

COHSM_DEF cohsm_result cohsm_write(const cohsm_maps *m, void *memory, size_t memory_bytes)
{
    cohsm__logger log = cohsm__logger_of_maps(m, "cohsm_write");
    uint32_t i;

    if (!m) return COHSM_ERR_ARGUMENT;
    if (!memory) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "memory", "is NULL");
    if (memory_bytes < 4 * (size_t)m->head.words) {
        cohsm__log_value(&log, "memory_bytes", (double)memory_bytes, "cohsm_info.bytes or more");
        return COHSM_ERR_MEMORY;
    }
    for (i = 0; i < m->head.words; i++) cohsm__put_u32((uint8_t *)memory + 4 * (size_t)i, m->words[i]);
    return COHSM_OK;
}

static cohsm_result cohsm__open_file(const uint8_t *file, size_t bytes, const cohsm__allocator *a,
                                     const cohsm__part *part, cohsm_maps **out)
{
    if (bytes < 16) return COHSM_ERR_FORMAT;
#ifndef COHSM_WITHOUT_PACK
    if (cohsm__get_u32(file) == COHSM__PACK_MAGIC) return cohsm__unpack(file, bytes, a, part, out);
#else
    if (cohsm__get_u32(file) == COHSM__PACK_MAGIC) return COHSM_ERR_MISMATCH;
#endif
    if (cohsm__get_u32(file) != COHSM__MAGIC) return COHSM_ERR_FORMAT;
    if (cohsm__get_u32(file + 4) != COHSM__FORMAT) return COHSM_ERR_VERSION;
    return cohsm__open_plain(file, bytes, a, part, out);
}

/* Opens a file and lays the maps out as wanted. If trays may be wanted, the second half of the progress is
   theirs. */
static cohsm_result cohsm__open_wished(const void *data, size_t bytes, const cohsm__wish *wish,
                                       const cohsm__logger *log, cohsm_maps **out)
{
    cohsm__allocator a;
    cohsm__part part, opening;
    cohsm_maps *maps = NULL;
    cohsm_result result;

    if (!data) return cohsm__refuse(log, COHSM_ERR_ARGUMENT, "data", "is NULL");
    if (!out) return cohsm__refuse(log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (!cohsm__services_of(wish->system, log, &a, &part)) return COHSM_ERR_DESC;
    opening = cohsm__part_of(&part, 0.0f, wish->layout == COHSM_LAYOUT_COMPACT ? 1.0f : 0.5f);
    result = cohsm__open_file((const uint8_t *)data, bytes, &a, &opening, &maps);
    part = cohsm__part_of(&part, 0.5f, 1.0f);
    if (result == COHSM_OK) result = cohsm__lay_out_opened(maps, wish, part, out);
    if (result == COHSM_ERR_FORMAT) cohsm__log_text(log, "data", "is no file of csm.h, or a damaged one");
    if (result == COHSM_ERR_VERSION) cohsm__log_text(log, "data", "is a file of an unknown version");
    if (result == COHSM_ERR_MISMATCH)
        cohsm__log_text(log, "data", "is a packed file, and this csm.h was joined without pack");
    cohsm__log_layout(log, "layout", result);
    return cohsm__log_result(log, result);
}

COHSM_DEF cohsm_result cohsm_open(const void *data, size_t bytes, const cohsm_system *system,
                                  cohsm_maps **out)
{
    cohsm__wish wish;
    cohsm__logger log = cohsm__logger_of(system, "cohsm_open");

    wish.layout = COHSM_LAYOUT_COMPACT;
    wish.bytes = 0;
    wish.system = system;
    return cohsm__open_wished(data, bytes, &wish, &log, out);
}

COHSM_DEF cohsm_result cohsm_open_as(const void *data, size_t bytes, cohsm_layout layout, size_t layout_bytes,
                                     const cohsm_system *system, cohsm_maps **out)
{
    cohsm__wish wish;
    cohsm__logger log = cohsm__logger_of(system, "cohsm_open_as");

    if ((unsigned)layout >= COHSM_LAYOUT_COUNT)
        return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "layout", "is no COHSM_LAYOUT_...");
    wish.layout = layout;
    wish.bytes = layout_bytes;
    wish.system = system;
    return cohsm__open_wished(data, bytes, &wish, &log, out);
}
