/* ---- kernels of query: depths of many lists ---- */

/* Does what cohsm__list_block does, and prefetches the block. */
static inline COHSM__IN_KERNEL void cohsm__find_block(cohsm__found *f, const uint32_t *lines)
{
    const uint32_t *directory = f->at;
    const uint32_t where = directory[1], rest = (where & 0xffffu) - 1u;
    const uint32_t count = cohsm__halves_up_to(directory + 2, rest, f->view);
    const uint32_t tail = 0u - (uint32_t)(count == rest);
    const uint32_t line = directory[0] + (count & ~tail) - (where >> 20 & tail);
    f->view -= cohsm__half_word(directory, count + 3u) & (0u - (uint32_t)(count > 0));
    f->at = lines + COHSM__BLOCK_WORDS * (size_t)line + (where >> 16 & 15u & tail);
    COHSM__PREFETCH(f->at);
}

/* Does what cohsm__depth_in_block does. */
static inline COHSM__IN_KERNEL uint32_t cohsm__found_depth(const cohsm__found *f, const uint16_t *depth_of)
{
    const uint64_t marks = cohsm__marks(f->at);
    const uint32_t bucket = f->view >> (f->at[0] >> 8 & 15u);
    const uint32_t at = bucket ? cohsm__nth_bit(~marks, bucket - 1u) + 1u : 0u;
    return cohsm__block_depth(f->at, depth_of, cohsm__bit_count(marks),
                              cohsm__segment_at(f->at, marks, f->view, at));
}

/* Finds the stored depths of up to a step of pixels, in loops that each prefetch what the next one reads. */
COHSM__KERNEL static void cohsm__find_depths(const cohsm_maps *m, const uint32_t *pixel,
                                             const uint32_t *place, uint32_t count, int32_t *depth)
{
    cohsm__found found[COHSM__STEP + 1];
    uint32_t n = 0, i;

#ifndef COHSM_WITHOUT_FAST
    if (m->trays.lines) {
        cohsm__tray_depths(m, pixel, place, count, depth);
        return;
    }
#endif
    for (i = 0; i < count; i++) {
        const uint32_t inside = pixel[i] != COHSM__NO_PIXEL;
        const uint32_t *lookup = m->lookup + (size_t)(place[i] >> COHSM__CHUNK_BITS) * m->range;
        const uint32_t entry = lookup[pixel[i] & (0u - inside)];
        const uint32_t listed = inside & (uint32_t)!(entry & COHSM__CONSTANT);
        depth[i] = inside ? (int32_t)(entry & 0xffffu) : COHSM__INFINITE;       /* nothing is deeper */
        found[n].at = m->directories + (entry & (0u - listed));
        found[n].view = place[i] & (COHSM__CHUNK - 1u);
        found[n].sample = i;
        COHSM__PREFETCH(found[n].at);
        n += listed;
    }
    for (i = 0; i < n; i++) cohsm__find_block(&found[i], m->lines);
    for (i = 0; i < n; i++) depth[found[i].sample] = (int32_t)cohsm__found_depth(&found[i], m->depth_of);
}

#if COHSM__LANE_COUNT == 8
/* Makes the samples of the tile dark that lie deeper than what is stored. */
COHSM__KERNEL static void cohsm__search_tile(cohsm__tile *t)
{
    int32_t stored[COHSM__TILE];
    const uint32_t step = t->maps->trays.lines ? (uint32_t)COHSM__TILE : (uint32_t)COHSM__STEP;
    uint32_t i, k, n;

    for (i = 0; i < t->count; i += n) {
        n = cohsm__min_u32(step, (uint32_t)t->count - i);
        cohsm__find_depths(t->maps, t->pixel + i, t->place + i, n, stored);
        for (k = n; k % COHSM__LANE_COUNT; k++) stored[k] = COHSM__INFINITE;
        for (k = 0; k < n; k += COHSM__LANE_COUNT) {
            const cohsm__lane_mask dark = cohsm__ints_greater(cohsm__ints_load(t->depth + i + k),
                                                              cohsm__ints_load(stored + k));
            const cohsm__lanes visible = cohsm__lanes_load(t->visible + i + k);
            cohsm__lanes_store(t->visible + i + k,
                               cohsm__lanes_select(dark, cohsm__lanes_all(0.0f), visible));
        }
    }
}

/* Loads vectors of the query as (v - center) scale, as long as the samples of all lanes are neighbours in the
   query, which is so for all but the last few of a batch. Returns how many were loaded. */
COHSM__KERNEL static size_t cohsm__load_vectors(const cohsm__tile *t, const float *packed, cohsm__v3 center,
                                                float scale, float (*out)[COHSM__TILE])
{
    const cohsm__lanes3 c = cohsm__lanes3_all(center.x, center.y, center.z);
    const size_t last = COHSM__LANE_COUNT - 1;
    size_t i;

    for (i = 0; i + last < t->count && t->id[i + last] == t->id[i] + last; i += COHSM__LANE_COUNT) {
        const cohsm__lanes3 v = cohsm__lanes3_scale(
            cohsm__lanes3_sub(cohsm__lanes3_load_packed(packed + 3 * t->id[i]), c), cohsm__lanes_all(scale));
        cohsm__lanes_store(out[0] + i, v.x);
        cohsm__lanes_store(out[1] + i, v.y);
        cohsm__lanes_store(out[2] + i, v.z);
    }
    return i;
}
#endif
