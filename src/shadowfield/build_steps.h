/* ---- building: from a desc to a field ---- */

/* Makes the tables, the scratch of every task, and room for the values of a batch. */
static sfield_result sfield__prepare_build(sfield__build *b)
{
    const uint32_t haar = b->h.basis == SFIELD_BASIS_HAAR, planes = haar ? 0 : b->planes;
    const int mesh = b->triangles > 0, deep = b->what == SFIELD__EMISSIVE;
    size_t width = deep ? SFIELD__EMISSIVE_WIDTH : SFIELD__MOST_WIDTH, samples = 6 * width * width;
    size_t floats = b->h.channels * b->cells * (haar ? 2u : 1u) + (haar ? 2 * b->cells : 0), p;
    float *tables = (float *)sfield__hold_memory(b, b->cells, (4 + planes) * sizeof(float)), *all;
    uint8_t *buffers;
    double *work = NULL;
    uint32_t i, k;
    b->pieces = deep ? 4u : (uint32_t)SFIELD__PIECES;
    b->view = (sfield__view *)sfield__hold_memory(b, b->pieces, sizeof *b->view);
    all = (float *)sfield__hold_memory(b, b->pieces, floats * sizeof *all);
    buffers = (uint8_t *)sfield__hold_memory(b, b->pieces, mesh ? (deep ? 8 * samples : samples / 8) : 1);
    if (!tables || !b->view || !all || !buffers) return SFIELD_ERR_ALLOC;
    if (b->h.logarithm) {
        sfield_result result = sfield_algebra_create(b->h.bands, &b->desc.system, &b->algebra);
        work = (double *)sfield__hold_memory(b, b->pieces,
                                      2 * sizeof *work * b->h.bands * b->h.bands * b->h.bands * b->h.bands);
        if (result != SFIELD_OK || !work) return SFIELD_ERR_ALLOC;
    }
    memset(b->view, 0, b->pieces * sizeof *b->view);
    if (mesh) memset(buffers, 0, b->pieces * (deep ? 8 * samples : samples / 8));
    for (p = 0; p < b->pieces; p++) {
        sfield__view *v = &b->view[p];
        v->texel = all + p * floats;
        v->haar = v->texel + b->h.channels * b->cells;
        v->key = v->haar + b->h.channels * b->cells;
        v->bits = (uint64_t *)(void *)(buffers + p * (mesh && !deep ? samples / 8 : 0));
        v->depth = deep ? (float *)(void *)(buffers + 8 * p * samples) : NULL;
        v->owner = deep ? (uint32_t *)(void *)(v->depth + samples) : NULL;
        v->work = work ? work + 2 * p * b->h.bands * b->h.bands * b->h.bands * b->h.bands : NULL;
    }
    b->texels.direction = tables;
    b->texels.angle = tables + 3 * b->cells;
    b->texels.basis = tables + 4 * b->cells;
    memset(tables, 0, b->cells * (4 + planes) * sizeof *tables);
    for (i = 0; i < b->cells; i++) {
        b->texels.angle[i] = sfield_cube_texel(b->h.cube_side, i, b->texels.direction + 3 * i);
        if (!haar) sfield__texel_basis(b->h.bands, b->h.cube_side, i, b->texels.basis + (size_t)i * planes);
    }
    /* odd about the middle, and exact at the ends */
    for (i = 0, k = b->h.position_side; i < k; i++) {
        float s, c, a = 2 * (float)(i < k / 2 ? i : k - 1 - i) / (float)(k - 1) - 1;
        sfield__sincos(0.785398163f * a, &s, &c);
        b->texels.node[i] = (i == 0 || i == k - 1 ? -1 : s / c) * (i < k / 2 ? 1.0f : -1.0f);
    }
    return SFIELD_OK;
}

static sfield_result sfield__hold_batch(sfield__build *b, size_t batch)
{
    size_t held = b->what == SFIELD__SELF ? b->h.samples : batch;
    sfield_result result;
    if (b->what == SFIELD__VIEWS) {
        b->seen_size = b->h.channels * (b->h.bands ? b->h.bands * b->h.bands : b->cells);
        b->eyes = (float *)sfield__hold_memory(b, SFIELD__MOST_VIEWS, 3 * sizeof *b->eyes);
        b->seen = (float *)sfield__hold_memory(b, SFIELD__MOST_VIEWS, b->seen_size * sizeof *b->seen);
        b->moved = (uint8_t *)sfield__hold_memory(b, SFIELD__MOST_VIEWS, 1);
        if (!b->eyes || !b->seen || !b->moved) return SFIELD_ERR_ALLOC;
    }
#ifndef SFIELD_WITHOUT_WAVELETS
    if (b->h.basis == SFIELD_BASIS_HAAR) return sfield__hold_wavelets(b, batch);
#endif
    b->value = (float *)sfield__hold_memory(b, held, b->h.stride * sizeof *b->value);
    if (!b->value) return SFIELD_ERR_ALLOC;
    result = sfield__alloc_field(&b->allocator, &b->log, &b->h, &b->out);
    if (result == SFIELD_OK && b->h.shard_end) memset(b->out->words, 0, b->out->h.bytes);
    return result;
}

static sfield_result sfield__build_batches(sfield__build *b)
{
    const int self = b->what == SFIELD__SELF, haar = b->h.basis == SFIELD_BASIS_HAAR;
    const float *radiance = b->radiance;
    size_t batch = self ? 2048 : 6 * (size_t)b->h.position_side * b->h.position_side;
    uint32_t groups = self ? (b->h.samples + 2047) / 2048 : sfield__groups(&b->h), g;
    const uint32_t begin = b->h.shard_begin, end = b->h.shard_end ? b->h.shard_end : groups;
    float *values;
    sfield_result result = sfield__hold_batch(b, batch);
    if (!sfield__tell_progress(b, 0)) return SFIELD_ERR_CANCELLED;
    values = b->value;
    for (g = begin; g < end && result == SFIELD_OK; g++) {
        b->first = g * batch;
        b->count = self && b->h.samples - b->first < batch ? b->h.samples - b->first : batch;
        b->radius = self ? 0 : b->radii[g % b->h.shells];
        b->time = self ? 0 : (float)(g / b->h.shells) / b->h.frames_per_second;
        if (radiance) b->radiance = radiance + 3 * (size_t)(g / b->h.shells) * (b->triangles + b->skipped);
        if (self && !haar) b->value = values + b->first * b->h.stride;
        result = sfield__build_batch(b, g);
        if (result == SFIELD_OK && !sfield__tell_progress(b, (float)(g + 1 - begin) / (float)(end - begin)))
            return SFIELD_ERR_CANCELLED;
    }
    if (result != SFIELD_OK || !self || haar) return result;
    b->value = values;                          /* one range for all points */
    b->count = b->h.samples;
    sfield__quantise(b, 0, 0);
    return SFIELD_OK;
}

static sfield_result sfield__finish_field(sfield__build *b, sfield_field **out, sfield_stats *stats)
{
    double lost = 0, total = 0;
    const sfield__part silent = { NULL, NULL, 0, 1 };
    uint32_t p;
#ifndef SFIELD_WITHOUT_WAVELETS
    if (b->h.basis == SFIELD_BASIS_HAAR) {
        const sfield_result result = sfield__finish_wavelets(b);
        if (result != SFIELD_OK) return result;
    }
#endif
    if (b->h.kind == SFIELD__KIND_OCCLUSION && b->triangles) b->out->h.inscribed = sfield__find_inscribed(b);
    memcpy(b->out->words + SFIELD__HEADER, b->radii, b->h.shells * sizeof *b->radii);
    sfield__bind_shells(b->out);
    sfield__seal_block(b->out, &silent);
    b->peak = (b->peak > b->bytes ? b->peak : b->bytes) + b->out->h.bytes;
    if (stats) {
        memset(stats, 0, sizeof *stats);
        for (p = 0; p < b->pieces; p++) {
            lost += b->view[p].lost;
            total += b->view[p].total;
            stats->moved += b->view[p].moved;
        }
        stats->triangles = (uint32_t)b->triangles;
        stats->skipped_triangles = b->skipped;
        stats->coefficients = b->h.entries;
        stats->lost = total > 0 ? sqrt(lost / total) : 0;
        stats->peak_bytes = b->peak;
    }
    *out = b->out;
    b->out = NULL;
    return SFIELD_OK;
}

static sfield_result sfield__run_build(sfield__build *b, sfield_field **out, sfield_stats *stats)
{
    sfield_result result;
    if (sfield__block_bytes(&b->h) > 0xffffffffu)
        return sfield__fail(&b->log, SFIELD_ERR_LIMIT, "desc", "asks for a field of more than 4 GB");
    result = sfield__prepare_build(b);
    if (result == SFIELD_OK) result = sfield__build_batches(b);
    if (result == SFIELD_OK) result = sfield__finish_field(b, out, stats);
    if (result == SFIELD_ERR_LIMIT) sfield__log_text(&b->log, "desc", "asks for a field of more than 4 GB");
    return result;
}
