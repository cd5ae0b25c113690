/* ---- files: the block as bytes, and back ---- */

COHSM_DEF const void *cohsm_data(const cohsm_maps *m, size_t *bytes)
{
    if (!m) return NULL;
    if (bytes) *bytes = 4 * (size_t)m->head.words;
    return m->words;
}

COHSM_DEF cohsm_result cohsm_write(const cohsm_maps *m, void *memory, size_t memory_bytes)
{
    uint32_t i;
    if (!m || !memory) return COHSM_ERR_ARGUMENT;
    if (memory_bytes < 4 * (size_t)m->head.words) return COHSM_ERR_MEMORY;
    for (i = 0; i < m->head.words; i++) cohsm__put_u32((uint8_t *)memory + 4 * (size_t)i, m->words[i]);
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_open(const void *data, size_t bytes, const cohsm_system *system,
                                  cohsm_maps **out)
{
    const uint8_t *file = (const uint8_t *)data;
    cohsm__allocator a;
    cohsm__part part;
    cohsm__logger log = cohsm__logger_of(system, "cohsm_open");

    if (!data) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "data", "is NULL");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (!cohsm__services_of(system, &log, &a, &part)) return COHSM_ERR_DESC;
    if (bytes < 16) return COHSM_ERR_FORMAT;
#ifndef COHSM_WITHOUT_PACK
    if (cohsm__get_u32(file) == COHSM__PACK_MAGIC)
        return cohsm__ended(&log, cohsm__unpack(file, bytes, &a, &part, out));
#endif
    if (cohsm__get_u32(file) != COHSM__MAGIC) return COHSM_ERR_FORMAT;
    if (cohsm__get_u32(file + 4) != COHSM__FORMAT) return COHSM_ERR_VERSION;
    return cohsm__ended(&log, cohsm__open_plain(file, bytes, &a, &part, out));
}
