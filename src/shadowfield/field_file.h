/* ---- fields: files, and shards of a field joined ---- */

static void sfield__write_words(uint8_t *to, const uint32_t *from, size_t count)
{
    size_t i;
    if (sfield__host_is_little_endian()) memcpy(to, from, 4 * count);
    else
        for (i = 0; i < count; i++) sfield__put_u32(to + 4 * i, from[i]);
}

/* How many bytes, or samples of wavelets, lie between two calls of progress, which takes milliseconds. */
enum { SFIELD__STEP = 1 << 18, SFIELD__STEP_SAMPLES = 1024 };

/* Takes a call's allocator and progress. Returns 0 if the allocator has one of its two functions alone. */
static int sfield__services_of(const sfield_system *system, sfield__allocator *a, sfield__part *part)
{
    if (!sfield__system_good(system)) return 0;
    *a = sfield__allocator_of(system);
    part->progress = system ? system->progress : NULL;
    part->user = system ? system->user : NULL;
    part->from = 0;
    part->to = 1;
    return 1;
}

/* Adds bytes to a checksum. Returns 0 if the caller cancels. */
static int sfield__add_to_crc(uint32_t *crc, const uint8_t *bytes, size_t size, sfield__part part)
{
    size_t i, n;
    for (i = 0; i < size; i += n) {
        if (sfield__cancelled(&part, i, size, 1)) return 0;
        n = size - i < SFIELD__STEP ? size - i : (size_t)SFIELD__STEP;
        *crc = sfield__crc32(*crc, bytes + i, n);
    }
    return 1;
}

/* Computes the checksum of a field's bytes as a file has them, from the word after the checksum itself to the
   end. Returns 0 if the caller cancels. */
static int sfield__checksum(const sfield_field *f, const sfield__part *part, uint32_t *crc)
{
    const size_t total = f->word_count - 4, sampled = f->h.bytes - 4 * f->word_count;
    const float share = (float)(4.0 * (double)total / (4.0 * (double)total + (double)sampled));
    const sfield__part words = sfield__part_of(part, 0, share);
    uint8_t chunk[1024];
    size_t i, n;
    *crc = 0;
    for (i = 0; i < total; i += n) {
        if (sfield__cancelled(&words, i, total, SFIELD__STEP / 4)) return 0;
        n = total - i < 256 ? total - i : 256;
        sfield__write_words(chunk, f->words + 4 + i, n);
        *crc = sfield__crc32(*crc, chunk, 4 * n);
    }
    return sfield__add_to_crc(crc, f->sample, sampled, sfield__part_of(part, share, 1));
}

/* Returns whether coefficient k of group g is everywhere `ratio` times coefficient `of`, to the bits that are
   kept. The first coefficient of the channel that `of` is in says how much that is. */
static int sfield__is_multiple(const sfield_field *f, uint32_t g, uint32_t k, uint32_t of, float ratio)
{
    const size_t stride = f->h.stride, samples = f->h.samples / (f->h.shells * f->h.frames);
    const float *scale = f->scale + g * stride, *bias = f->bias + g * stride;
    const uint32_t first = of / f->planes * f->planes;
    const float s = scale[k], b = bias[k], u = ratio * scale[of], v = ratio * bias[of];
    const float most = s + 1e-5f * ratio * fabsf(bias[first] + 255 * scale[first]);
    const uint8_t *q = f->sample + samples * g * stride;
    size_t i;
    for (i = 0; i < samples; i++, q += stride)
        if (!(fabsf(s * (float)q[k] + b - u * (float)q[of] - v) <= most)) return 0;
    return 1;
}

/* Finds the channel that the others are multiples of, as those of lamps of one colour are, to the bits that
   are kept: then that channel is enough. Returns 0 if the caller cancels. */
static int sfield__find_tone(sfield_field *f, sfield__part part)
{
    const uint32_t n = f->planes;
    uint32_t c, k, g, t = 0;
    f->tone = 3;
    if (f->h.channels != 3 || f->h.basis != SFIELD_BASIS_SH || f->h.shard_end) return 1;
    for (c = 0; c < 3; c++) {
        /* This is the greatest mean that a sample of the first shell has. */
        f->ratio[c] = f->bias[c * n] + 255 * f->scale[c * n];
        if (f->ratio[c] > f->ratio[t]) t = c;
    }
    if (!(f->ratio[t] > 0)) return 1;
    for (c = 0; c < 3; c++) f->ratio[c] = c == t ? f->ratio[c] : f->ratio[c] / f->ratio[t];
    f->ratio[t] = 1;
    for (g = 0; g < sfield__groups(&f->h); g++) {
        if (sfield__cancelled(&part, g, sfield__groups(&f->h), 1)) return 0;
        for (c = 0; c < 3; c++)
            for (k = 0; k < n && c != t; k++)
                if (!sfield__is_multiple(f, g, c * n + k, t * n + k, f->ratio[c])) return 1;
    }
    f->tone = t;
    return 1;
}

/* Writes the header into a block, with its checksum. Returns 0 if the caller cancels. */
static int sfield__seal_block(sfield_field *f, const sfield__part *part)
{
    sfield__part first;
    memcpy(f->words, &f->h, sizeof f->h);
    first = sfield__part_of(part, 0, 0.9f);
    if (!sfield__checksum(f, &first, &f->h.crc)) return 0;
    memcpy(f->words, &f->h, sizeof f->h);
    return sfield__find_tone(f, sfield__part_of(part, 0.9f, 1));
}

SFIELD_DEF size_t sfield_bytes(const sfield_field *field) { return field ? field->h.bytes : 0; }

SFIELD_DEF sfield_result sfield_write(const sfield_field *field, void *memory, size_t memory_bytes)
{
    sfield__logger log;
    if (!field) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_for(&field->log, "sfield_write");
    if (!memory) return sfield__fail_null(&log, "memory");
    if (!sfield__check_value(&log, memory_bytes >= field->h.bytes, "memory_bytes", (double)memory_bytes,
                             "at least what sfield_bytes returns"))
        return SFIELD_ERR_MEMORY;
    sfield__write_words((uint8_t *)memory, field->words, field->word_count);
    if (field->h.basis == SFIELD_BASIS_SH)
        memcpy((uint8_t *)memory + 4 * field->word_count, field->sample,
               (size_t)field->h.samples * field->h.stride);
    return SFIELD_OK;
}

#ifndef SFIELD_WITHOUT_WAVELETS
/* Checks that offsets rise, that scales are in range, and that indices rise in each list. */
static sfield_result sfield__check_lists(const sfield_field *f, sfield__part part)
{
    const sfield__header *h = &f->h;
    const float most = sfield__most_value(h) / 32767;
    uint32_t i, k, cells = 6 * h->cube_side * h->cube_side;
    if (f->offset[0] != 0 || f->offset[h->samples] != h->entries) return SFIELD_ERR_FORMAT;
    /* shards: nothing outside, so that sfield_merge fits */
    k = h->shard_end ? h->samples / sfield__groups(h) : 0;
    if (k && (f->offset[h->shard_begin * k] != 0 || f->offset[h->shard_end * k] != h->entries))
        return SFIELD_ERR_FORMAT;
    for (i = 0; i < h->samples; i++) {
        if (sfield__cancelled(&part, i, h->samples, SFIELD__STEP_SAMPLES)) return SFIELD_ERR_CANCELLED;
        if (f->offset[i] > f->offset[i + 1] || f->offset[i + 1] > h->entries) return SFIELD_ERR_FORMAT;
        if (!sfield__in(f->sample_scale[i], 0, most)) return SFIELD_ERR_FORMAT;
        for (k = f->offset[i]; k < f->offset[i + 1]; k++) {
            uint32_t index = f->entry[(size_t)k * h->stride] >> 16;
            if (index >= cells || (k > f->offset[i] && index <= f->entry[(size_t)(k - 1) * h->stride] >> 16))
                return SFIELD_ERR_FORMAT;
        }
    }
    return SFIELD_OK;
}
#endif

static sfield_result sfield__check_content(const sfield_field *f, sfield__part part)
{
    const sfield__header *h = &f->h;
    const float most = sfield__most_value(h);
    uint32_t i, count = sfield__groups(h) * h->stride;
    for (i = 0; i < h->shells; i++)
        if (!sfield__in(f->radii[i], 1e-6f, 1000) || (i && f->radii[i] <= f->radii[i - 1] * 1.0001f))
            return SFIELD_ERR_FORMAT;
    if (h->basis == SFIELD_BASIS_SH) {
        for (i = 0; i < count; i++)
            if (!sfield__in(255 * f->scale[i], -most, most) || !sfield__in(f->bias[i], -most, most))
                return SFIELD_ERR_FORMAT;
        return SFIELD_OK;
    }
#ifndef SFIELD_WITHOUT_WAVELETS
    return sfield__check_lists(f, part);
#else
    (void)part;
    return SFIELD_ERR_FORMAT;
#endif
}

/* Reads the block from a file's bytes. Returns 0 if the caller cancels. */
static int sfield__read_words(sfield_field *f, const uint8_t *bytes, sfield__part part)
{
    const size_t total = f->h.bytes, words = 4 * f->word_count;
    size_t i, k, n;
    for (i = 0; i < total; i += n) {
        if (sfield__cancelled(&part, i, total, 1)) return 0;
        n = i < words ? words - i : total - i;
        n = n < SFIELD__STEP ? n : (size_t)SFIELD__STEP;
        if (i < words)
            for (k = i / 4; k < (i + n) / 4; k++) f->words[k] = sfield__get_u32(bytes + 4 * k);
        else memcpy((uint8_t *)f->words + i, bytes + i, n);
    }
    return 1;
}

/* Fills a field from a file whose header and checksum are right. */
static sfield_result sfield__take_file(sfield_field *f, const uint8_t *bytes, const sfield__part *part)
{
    sfield_result result;
    if (!sfield__read_words(f, bytes, sfield__part_of(part, 0, 0.3f))) return SFIELD_ERR_CANCELLED;
    sfield__bind_shells(f);
    result = sfield__check_content(f, sfield__part_of(part, 0.3f, 0.7f));
    if (result != SFIELD_OK) return result;
    return sfield__find_tone(f, sfield__part_of(part, 0.7f, 1)) ? SFIELD_OK : SFIELD_ERR_CANCELLED;
}

SFIELD_DEF sfield_result sfield_open(const void *data, size_t bytes, const sfield_system *system,
                                     sfield_field **out)
{
    const sfield__logger log = sfield__logger_of(system, "sfield_open");
    const uint8_t *from = (const uint8_t *)data;
    uint32_t words[SFIELD__HEADER], i, crc = 0;
    sfield__allocator a;
    sfield__part part, rest;
    sfield__header h;
    sfield_field *f;
    sfield_result result;
    if (!data || !out) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, data ? "out" : "data", "is NULL");
    if (!sfield__services_of(system, &a, &part)) return sfield__fail_allocator(&log);
    if (bytes < sizeof h || sfield__get_u32(from) != SFIELD__MAGIC)
        return sfield__fail(&log, SFIELD_ERR_FORMAT, "data", "is not a file of shadowfield.h");
    if (sfield__get_u32(from + 4) != SFIELD__FORMAT) {
        sfield__log_value(&log, "the format of data", (double)sfield__get_u32(from + 4), "1");
        return SFIELD_ERR_VERSION;
    }
    for (i = 0; i < SFIELD__HEADER; i++) words[i] = sfield__get_u32(from + 4 * i);
    memcpy(&h, words, sizeof h);
#ifdef SFIELD_WITHOUT_WAVELETS
    if (h.basis == SFIELD_BASIS_HAAR)
        return sfield__fail(&log, SFIELD_ERR_MISMATCH, "data",
                            "holds wavelets, which this header was joined without");
#endif
    if (h.bytes != bytes || !sfield__header_good(&h) || sfield__block_bytes(&h) != bytes)
        return sfield__fail(&log, SFIELD_ERR_FORMAT, "data",
                            "has a damaged header, or another size than it says");
    if (!sfield__add_to_crc(&crc, from + 16, bytes - 16, sfield__part_of(&part, 0, 0.7f)))
        return SFIELD_ERR_CANCELLED;
    if (crc != h.crc)
        return sfield__fail(&log, SFIELD_ERR_FORMAT, "data", "does not have the checksum that it says");
    result = sfield__alloc_field(&a, &log, &h, &f);
    if (result != SFIELD_OK) return sfield__fail(&log, result, "data", "needs more memory than there is");
    rest = sfield__part_of(&part, 0.7f, 1);
    result = sfield__take_file(f, from, &rest);
    if (result == SFIELD_OK) {
        *out = f;
        return SFIELD_OK;
    }
    sfield_free(f);
    if (result == SFIELD_ERR_FORMAT) sfield__log_text(&log, "data", "holds numbers out of their range");
    return result;
}

/* Returns whether shard b continues where shard a ends, and was made in the same way. */
static int sfield__is_next_shard(const sfield_field *a, const sfield_field *b)
{
    sfield__header x = a->h, y = b->h;
    if (x.shard_end != y.shard_begin || !y.shard_end) return 0;
    x.bytes = x.crc = x.entries = x.shard_begin = x.shard_end = 0;
    y.bytes = y.crc = y.entries = y.shard_begin = y.shard_end = 0;
    return memcmp(&x, &y, sizeof x) == 0 && memcmp(a->radii, b->radii, x.shells * sizeof *a->radii) == 0;
}

/* Copies what a shard has built into the whole. *entries counts the wavelets there. */
static void sfield__join_shard(sfield_field *whole, const sfield_field *shard, uint32_t *entries)
{
    const sfield__header *h = &shard->h;
    size_t samples = h->samples / sfield__groups(h), first = h->shard_begin * samples, stride = h->stride, i;
    size_t groups = h->shard_end - h->shard_begin, at = h->shard_begin * stride;
    uint32_t *words = whole->words + SFIELD__HEADER + h->shells;
    samples *= groups;
    if (h->basis == SFIELD_BASIS_SH) {
        memcpy(words + at, shard->scale + at, 4 * groups * stride);
        memcpy(words + at + sfield__groups(h) * stride, shard->bias + at, 4 * groups * stride);
        memcpy((uint8_t *)(whole->words + whole->word_count) + first * stride, shard->sample + first * stride,
               samples * stride);
        return;
    }
    for (i = first; i < first + samples; i++) words[i + 1] = *entries + shard->offset[i + 1];
    memcpy(words + h->samples + 1 + first, shard->sample_scale + first, 4 * samples);
    if (h->entries)
        memcpy(words + 2 * (size_t)h->samples + 1 + *entries * stride, shard->entry, 4 * h->entries * stride);
    *entries += h->entries;
}

/* Copies all shards into the whole. Returns 0 if the caller cancels. */
static int sfield__join_shards(sfield_field *whole, const sfield_field *const *shards, size_t count,
                            sfield__part part)
{
    uint32_t used = 0;
    size_t i;
    memcpy(whole->words + SFIELD__HEADER, shards[0]->radii, whole->h.shells * sizeof *whole->radii);
    if (whole->h.basis == SFIELD_BASIS_HAAR) whole->words[SFIELD__HEADER + whole->h.shells] = 0;
    for (i = 0; i < count; i++) {
        if (sfield__cancelled(&part, i, count, 1)) return 0;
        sfield__join_shard(whole, shards[i], &used);
    }
    sfield__bind_shells(whole);
    return 1;
}

#ifndef SFIELD_WITHOUT_BUILD
SFIELD_DEF sfield_result sfield_merge(const sfield_field *const *shards, size_t count,
                                      const sfield_system *system, sfield_field **out)
{
    const sfield__logger log = sfield__logger_of(system, "sfield_merge");
    sfield__allocator a;
    sfield__part part, rest;
    uint64_t entries = 0;
    sfield__header h;
    sfield_field *f;
    sfield_result result;
    size_t i;
    if (!shards || !out) return sfield__fail_null(&log, shards ? "out" : "shards");
    if (!sfield__check_value(&log, count > 0, "count", 0, "> 0")) return SFIELD_ERR_ARGUMENT;
    if (!sfield__services_of(system, &a, &part)) return sfield__fail_allocator(&log);
    for (i = 0; i < count; i++) {
        const sfield_field *shard = shards[i];
        if (!shard) return sfield__fail_at(&log, SFIELD_ERR_ARGUMENT, "shards", i, "is NULL");
        if (i ? !sfield__is_next_shard(shards[i - 1], shard) : shard->h.shard_begin || !shard->h.shard_end)
            return sfield__fail_at(&log, SFIELD_ERR_MISMATCH, "shards", i,
                                   "does not go on where the one before ends");
        entries += shards[i]->h.entries;
    }
    h = shards[0]->h;
    if (shards[count - 1]->h.shard_end != sfield__groups(&h))
        return sfield__fail_at(&log, SFIELD_ERR_MISMATCH, "shards", count - 1,
                               "does not end with the last shell");
    if (entries > 0xffffffffu)
        return sfield__fail(&log, SFIELD_ERR_LIMIT, "shards", "have more wavelets than a field");
    h.entries = (uint32_t)entries;
    h.shard_end = 0;
    result = sfield__alloc_field(&a, &log, &h, &f);
    if (result != SFIELD_OK) return sfield__fail(&log, result, "shards", "need more memory than there is");
    rest = sfield__part_of(&part, 0.1f, 1);
    if (!sfield__join_shards(f, shards, count, sfield__part_of(&part, 0, 0.1f)) ||
        !sfield__seal_block(f, &rest)) {
        sfield_free(f);
        return SFIELD_ERR_CANCELLED;
    }
    *out = f;
    return SFIELD_OK;
}
#endif
