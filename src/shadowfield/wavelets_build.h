/* ---- wavelets: choosing and packing those that are kept ---- */

/* Returns the `rank`-th largest (0: the largest) of count values, which are put in another order. */
static float sfield__select_rank(float *a, uint32_t count, uint32_t rank)
{
    uint32_t low = 0, high = count - 1;
    while (low < high) {
        float pivot = a[(low + high) / 2];
        uint32_t i = low, j = high;
        for (;;) {
            float swap;
            while (a[i] > pivot) i++;
            while (a[j] < pivot) j--;
            if (i >= j) break;
            swap = a[i];
            a[i++] = a[j];
            a[j--] = swap;
        }
        if (rank <= j) high = j;
        else low = j + 1;
    }
    return a[rank];
}

/* Returns the weight of a wavelet for the choice: its side, that is the area times the height of a wavelet of
   norm 1 (Ng et al. 2003 call their choice area-weighted). */
static float sfield__weigh_wavelet(const sfield__build *b, const float *haar, uint32_t i)
{
    uint32_t in_face = i % (b->h.cube_side * b->h.cube_side), squares = 1, c;
    float most = 0, side = (float)b->h.cube_side;
    for (; 4 * squares <= in_face; squares *= 4) side *= 0.5f;
    for (c = 0; c < b->h.channels; c++) {
        float x = fabsf(haar[c * b->cells + i]);
        most = x > most ? x : most;
    }
    return most * side;
}

static uint32_t sfield__quantise_wavelet(float x, float scale)
{
    float q = scale > 0 ? x / scale : 0;
    return (uint32_t)(int32_t)(q + (q < 0 ? -0.5f : 0.5f)) & 0xffffu;
}

static void sfield__encode_haar(const sfield__build *b, sfield__view *v, uint32_t *kept, float *scale,
                                uint32_t *entry)
{
    uint32_t i, c, used = 0;
    uint32_t n = 0, equal;
    float threshold = 0, most = 0, *sorted = v->key + b->cells;
    for (c = 0; c < b->h.channels; c++)
        sfield__haar_cube(b->h.cube_side, v->texel + c * b->cells, v->haar + c * b->cells, b->simd);
    for (i = 0; i < b->cells; i++) {
        v->key[i] = sfield__weigh_wavelet(b, v->haar, i);
        if (v->key[i] > 0) sorted[used++] = v->key[i];
    }
    if (used > b->most) threshold = sfield__select_rank(sorted, used, b->most - 1);
    for (i = 0, equal = b->most; i < b->cells; i++) equal -= v->key[i] > threshold && equal;
    for (i = 0; i < b->cells; i++) {
        int keep = v->key[i] > threshold || (v->key[i] == threshold && threshold > 0 && equal > 0);
        if (keep && v->key[i] == threshold) equal--;
        for (c = 0; c < b->h.channels; c++) {
            float x = v->haar[c * b->cells + i];
            v->total += (double)x * (double)x;
            if (!keep) v->lost += (double)x * (double)x;
            else most = fabsf(x) > most ? fabsf(x) : most;
        }
        if (keep) sorted[n++] = (float)i;
    }
    *scale = most / 32767;
    *kept = n;
    for (i = 0; i < n; i++) {
        uint32_t at = (uint32_t)sorted[i];
        entry[0] = at << 16 | sfield__quantise_wavelet(v->haar[at], *scale);
        if (b->h.channels == 3)
            entry[1] = sfield__quantise_wavelet(v->haar[b->cells + at], *scale) << 16 |
                       sfield__quantise_wavelet(v->haar[2 * b->cells + at], *scale);
        entry += b->h.stride;
    }
}

/* Appends the wavelets of a batch to those of all. */
static sfield_result sfield__append_wavelets(sfield__build *b, size_t first)
{
    size_t i, n = 0;
    for (i = 0; i < b->count; i++) n += b->kept[i];
    if (n > 0xffffffffu - b->all_used) return SFIELD_ERR_LIMIT;
    /* Room is made for no wavelets too, so that there is a pointer to add 0 to. */
    if (!b->all || b->all_used + n > b->all_room) {
        uint64_t room = ((uint64_t)b->all_used + n) * 3 / 2 + 1024;
        uint32_t *grown;
        room = room < 0xffffffffu ? room : 0xffffffffu;
        if (room > SIZE_MAX / (4 * b->h.stride)) return SFIELD_ERR_LIMIT;
        grown = (uint32_t *)sfield__alloc_array(&b->allocator, (size_t)room, 4 * b->h.stride);
        if (!grown) return SFIELD_ERR_ALLOC;
        if (b->all) memcpy(grown, b->all, 4 * (size_t)b->all_used * b->h.stride);
        sfield__free(&b->allocator, b->all);
        b->all = grown;
        b->peak = b->bytes + 4 * (size_t)(room + b->all_room) * b->h.stride;
        b->all_room = (uint32_t)room;
    }
    for (i = 0; i < b->count; i++) {
        b->offsets[first + i] = b->all_used;
        b->scales[first + i] = b->kept_scale[i];
        memcpy(b->all + (size_t)b->all_used * b->h.stride, b->entry + i * b->most * b->h.stride,
               4 * (size_t)b->kept[i] * b->h.stride);
        b->all_used += b->kept[i];
    }
    b->offsets[first + b->count] = b->all_used;
    return SFIELD_OK;
}

/* Allocates room for the wavelets of a batch, and for the offsets and scales of all samples. */
static sfield_result sfield__hold_wavelets(sfield__build *b, size_t batch)
{
    b->kept = (uint32_t *)sfield__hold_memory(b, batch, sizeof *b->kept);
    b->kept_scale = (float *)sfield__hold_memory(b, batch, sizeof *b->kept_scale);
    b->entry = (uint32_t *)sfield__hold_memory(b, batch, 4 * (size_t)b->most * b->h.stride);
    b->offsets = (uint32_t *)sfield__hold_memory(b, (size_t)b->h.samples + 1, sizeof *b->offsets);
    b->scales = (float *)sfield__hold_memory(b, b->h.samples, sizeof *b->scales);
    if (!b->kept || !b->kept_scale || !b->entry || !b->offsets || !b->scales) return SFIELD_ERR_ALLOC;
    memset(b->offsets, 0, ((size_t)b->h.samples + 1) * sizeof *b->offsets);
    memset(b->scales, 0, (size_t)b->h.samples * sizeof *b->scales);
    return SFIELD_OK;
}

/* Makes the block of a field from the wavelets of all batches. */
static sfield_result sfield__finish_wavelets(sfield__build *b)
{
    sfield_result result;
    size_t i;
    b->h.entries = b->all_used;
    /* Samples behind those of the shard have no entries. */
    for (i = b->first + b->count; i < b->h.samples; i++) b->offsets[i + 1] = b->all_used;
    result = sfield__alloc_field(&b->allocator, &b->log, &b->h, &b->out);
    if (result != SFIELD_OK) return result;
    memcpy(b->out->words + SFIELD__HEADER + b->h.shells, b->offsets, 4 * ((size_t)b->h.samples + 1));
    memcpy(b->out->words + SFIELD__HEADER + b->h.shells + b->h.samples + 1, b->scales,
           4 * (size_t)b->h.samples);
    if (b->all_used)
        memcpy(b->out->words + b->out->word_count - (size_t)b->all_used * b->h.stride, b->all,
               4 * (size_t)b->all_used * b->h.stride);
    return SFIELD_OK;
}
