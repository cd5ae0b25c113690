/* ---- csm: blocks and instances ---- */

enum {
    GLBK__CSM_RECORD = 5,                   /* texels of an instance */
    GLBK__CSM_MAGIC = 0x4d534344,
    GLBK__CSM_FAST_MAGIC = 0x46534344,      /* of what cohsm_fast_data returns */
    GLBK__CSM_FORMAT = 1
};

/* Words of a block's header, of which docs/csm-format.md has all. */
enum {
    GLBK__CSM_WORD_MAGIC = 0, GLBK__CSM_WORD_FORMAT = 1,
    GLBK__CSM_WORD_COUNT = 2,               /* how many words the block has */
    GLBK__CSM_WORD_KEPT = 4,                /* texel 1: glbk__csm_head has the words from here on */
    GLBK__CSM_WORD_DOMAIN = 4, GLBK__CSM_WORD_ORDER = 6, GLBK__CSM_WORD_ORIENTATION = 7,
    GLBK__CSM_WORD_SIDE = 8,                /* three, of the domain */
    GLBK__CSM_WORD_MAP_SIDE = 13, GLBK__CSM_WORD_SELF_ONLY = 17,
    GLBK__CSM_WORD_SECTIONS = 20,           /* five lengths: of order, locations, the last three sections */
    GLBK__CSM_WORD_SPHERE = 27,             /* four floats: centre and radius */
    GLBK__CSM_HEADER = 96                   /* words of the header */
};

/* Returns a word of a block's header. */
static uint32_t glbk__csm_word(const glbk_csm_block *b, uint32_t word)
{
    uint32_t value;
    memcpy(&value, (const char *)b->data + 4 * word, sizeof value);
    return value;
}

/* Finds the words at which the three last sections of a fast block begin and, in at[3], the last one ends. */
static void glbk__csm_sections(const glbk_csm_block *b, uint64_t at[4])
{
    const uint32_t order = glbk__csm_word(b, GLBK__CSM_WORD_SECTIONS),
                   locations = glbk__csm_word(b, GLBK__CSM_WORD_SECTIONS + 1);
    uint32_t k;
    at[0] = ((uint64_t)GLBK__CSM_HEADER + order + locations + 15) / 16 * 16;
    for (k = 0; k < 3; k++) at[k + 1] = at[k] + glbk__csm_word(b, GLBK__CSM_WORD_SECTIONS + 2 + k);
}

/* Checks magic, format and length of block i, as docs/csm-format.md has them, in the host's byte order: that
   of GL. */
static glbk_result glbk__csm_check_block(const glbk_context *ctx, const glbk_csm_block *b, size_t i)
{
    static const char function[] = "glbk_csm_maps_create";
    uint64_t sections[4];
    uint32_t magic, words, format;
    if (!b->data)
        return glbk__refuse_element(ctx, GLBK_ERR_ARGUMENT, function, "blocks", i, ".data", "is NULL");
    if (b->bytes < 400 || b->bytes % 16)
        return glbk__refuse_element_value(ctx, GLBK_ERR_FORMAT, function, "blocks", i, ".bytes",
                                          (double)b->bytes, "what cohsm_data says: a multiple of 16, >= 400");
    magic = glbk__csm_word(b, GLBK__CSM_WORD_MAGIC);
    words = glbk__csm_word(b, GLBK__CSM_WORD_COUNT);
    format = glbk__csm_word(b, GLBK__CSM_WORD_FORMAT);
    if (magic != GLBK__CSM_MAGIC && magic != GLBK__CSM_FAST_MAGIC)
        return glbk__refuse_element(ctx, GLBK_ERR_FORMAT, function, "blocks", i, ".data",
                                    "begin with other bytes than a block of csm.h");
    if (words != b->bytes / 4)
        return glbk__refuse_element_value(ctx, GLBK_ERR_FORMAT, function, "blocks", i, ".bytes",
                                          (double)b->bytes, "four times the length that its header names");
    if (format != GLBK__CSM_FORMAT)
        return glbk__refuse_element_value(ctx, GLBK_ERR_VERSION, function, "blocks", i, "'s version",
                                          (double)format, "1");
    if (magic == GLBK__CSM_MAGIC) return GLBK_OK;
    glbk__csm_sections(b, sections);
    if (sections[3] > words)
        return glbk__refuse_element_value(ctx, GLBK_ERR_FORMAT, function, "blocks", i,
                                          "'s sections end at word", (double)sections[3],
                                          "the length that its header names, or less");
    return GLBK_OK;
}

enum {
    GLBK__CSM_NEAR = 16,            /* instances that the uniform block has room for */
    GLBK__CSM_NEAR_TEXELS = 12      /* of each: its record and texels 1 to 7 of its block */
};

/* What instances need to know of their block: the texel at which it begins, and texels 1 to 7 of it. */
typedef struct glbk__csm_head { uint32_t start, words[28]; } glbk__csm_head;

/* Appends a define with a number below 20, unless it is 0. */
static void glbk__csm_define(glbk__sink *sink, const char *name, uint32_t value)
{
    char digit = (char)('0' + value % 10);
    if (!value) return;
    glbk__append_text(sink, name);
    if (value > 9) glbk__append_text(sink, "1");
    glbk__append(sink, &digit, 1);
}

/* Writes the defines by which a program for these blocks alone is compiled, and a number for them: domain,
   order, orientation and layout if all blocks have the same, and how many instances stand in the uniform
   block, if they fit. */
static void glbk__csm_write_defines(const glbk_csm_block *blocks, size_t count, glbk_csm_maps *out)
{
    enum { OF_DOMAIN, OF_ORDER, OF_ORIENTATION, KINDS };
    static const uint32_t word[KINDS] = { GLBK__CSM_WORD_DOMAIN, GLBK__CSM_WORD_ORDER,
                                          GLBK__CSM_WORD_ORIENTATION };
    static const uint32_t count_of[KINDS] = { COHSM_DOMAIN_COUNT, COHSM_ORDER_COUNT,
                                              COHSM_ORIENTATION_COUNT };
    uint32_t kind[KINDS] = { 0, 0, 0 }, layout, layouts = 0, k;
    glbk__sink sink = { NULL, 0, 0 };
    size_t i;
    for (i = 0; i < count; i++) {
        layouts |= glbk__csm_word(&blocks[i], GLBK__CSM_WORD_MAGIC) == GLBK__CSM_FAST_MAGIC ? 2u : 1u;
        for (k = 0; k < KINDS; k++) {
            const uint32_t value = glbk__csm_word(&blocks[i], word[k]);
            kind[k] = value < count_of[k] && (i == 0 || kind[k] == value) ? value : 0;
        }
    }
    if (count <= GLBK__CSM_NEAR && out->capacity <= GLBK__CSM_NEAR)
        out->near_count = out->capacity <= 1 ? 1 : GLBK__CSM_NEAR;
    sink.out = out->defines;
    sink.bytes = sizeof out->defines;
    glbk__csm_define(&sink, " COHSM_ONE_DOMAIN=", kind[OF_DOMAIN]);
    glbk__csm_define(&sink, " COHSM_ONE_ORDER=", kind[OF_ORDER]);
    glbk__csm_define(&sink, " COHSM_ONE_ORIENTATION=", kind[OF_ORIENTATION]);
    layout = layouts < 3 ? layouts : 0;
    glbk__csm_define(&sink, " COHSM_ONE_LAYOUT=", layout);
    glbk__csm_define(&sink, " CSM_INSTANCES=", out->near_count);
    out->key = (((layout * 16 + kind[OF_DOMAIN]) * 8 + kind[OF_ORDER]) * 4 + kind[OF_ORIENTATION]) * 4;
    out->key += out->near_count > 1 ? 2 : out->near_count;
}

/* Checks the blocks and finds where each begins, in texels; *texels receives how many there are in all. */
static glbk_result glbk__csm_line_up(const glbk_context *ctx, const glbk_csm_block *blocks, size_t count,
                                     uint32_t *starts, size_t *texels)
{
    static const char function[] = "glbk_csm_maps_create";
    glbk_result result = count ? glbk__require(ctx, function, "blocks", blocks) : GLBK_OK;
    size_t i;

    if (result == GLBK_OK && count) result = glbk__require(ctx, function, "starts", starts);
    *texels = 0;
    for (i = 0; i < count && result == GLBK_OK; i++) {
        result = glbk__csm_check_block(ctx, &blocks[i], i);
        if (result != GLBK_OK) return result;
        if (blocks[i].bytes / 16 > ((size_t)1 << 28) - *texels)
            return glbk__refuse_element_value(ctx, GLBK_ERR_LIMIT, function, "blocks", i, ".bytes",
                                              (double)blocks[i].bytes, "4 GB at most with those before");
        starts[i] = (uint32_t)*texels;
        *texels += blocks[i].bytes / 16;
        *texels += (size_t)-(ptrdiff_t)*texels & 3u;    /* so that no line of 64 bytes straddles two rows */
    }
    return result;
}

/* Keeps the headers of all blocks, in the order of their places. */
static glbk_result glbk__csm_keep_heads(glbk_context *ctx, const glbk_csm_block *blocks, size_t count,
                                        const uint32_t *starts, glbk_csm_maps *out)
{
    glbk_csm__allocator memory = glbk_csm__memory(ctx);
    glbk__csm_head *heads = (glbk__csm_head *)glbk_csm__alloc_array(&memory, count, sizeof *heads);
    size_t i;
    if (!heads) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i++) {
        heads[i].start = starts[i];
        memcpy(heads[i].words, (const char *)blocks[i].data + 4 * GLBK__CSM_WORD_KEPT,
               sizeof heads[i].words);
    }
    out->heads = heads;
    out->block_count = (uint32_t)count;
    return GLBK_OK;
}

/* Uploads a block. The lines of a fast block are bytes, and its last section half words: GLSL reads both from
   words, the lowest bits first, whatever the byte order of the host. */
static glbk_result glbk__csm_upload(glbk_context *ctx, const glbk_csm_maps *maps, uint32_t start,
                                    const glbk_csm_block *b)
{
    uint32_t words[4096];
    uint64_t sections[4];
    size_t at, n = 0, i;
    glbk_result result = GLBK_OK;

    if (glbk__csm_word(b, GLBK__CSM_WORD_MAGIC) == GLBK__CSM_MAGIC)
        return glbk__table_update(ctx, &maps->blocks, start, b->bytes / 16, b->data);
    glbk__csm_sections(b, sections);
    for (at = 0; at < b->bytes / 4 && result == GLBK_OK; at += n) {
        n = b->bytes / 4 - at < 4096 ? b->bytes / 4 - at : 4096;
        memcpy(words, (const char *)b->data + 4 * at, 4 * n);
        for (i = 0; i < n; i++) {
            unsigned char bytes[4];
            uint16_t halves[2];
            memcpy(bytes, words + i, sizeof bytes);
            memcpy(halves, words + i, sizeof halves);
            if (at + i >= sections[2]) words[i] = halves[0] | (uint32_t)halves[1] << 16;
            else if (at + i >= sections[0] && at + i < sections[1])
                words[i] = bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
                           (uint32_t)bytes[3] << 24;
        }
        result = glbk__table_update(ctx, &maps->blocks, start + at / 4, n / 4, words);
    }
    return result;
}

GLBK_DEF glbk_result glbk_csm_maps_create(glbk_context *ctx, const glbk_csm_block *blocks, size_t count,
                                          uint32_t capacity, uint32_t *starts, glbk_csm_maps *out)
{
    const uint32_t most = ((uint32_t)1 << 28) / GLBK__CSM_RECORD;
    size_t texels, i;
    glbk_result result;

    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result == GLBK_OK) result = glbk__csm_line_up(ctx, blocks, count, starts, &texels);
    if (result != GLBK_OK) return result;
    if (capacity > most)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "capacity", capacity, 0, most);
    out->texel_count = (uint32_t)texels;
    out->capacity = capacity;
    glbk__csm_write_defines(blocks, count, out);
    if (count) result = glbk__csm_keep_heads(ctx, blocks, count, starts, out);
    if (result == GLBK_OK)
        result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, texels + 1, &out->blocks);
    if (result == GLBK_OK && !out->near_count)
        result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, GLBK__CSM_RECORD * (size_t)capacity + 1,
                                    &out->instances);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_csm_scene), NULL, &out->scene);
    for (i = 0; i < count && result == GLBK_OK; i++)
        result = glbk__csm_upload(ctx, out, starts[i], &blocks[i]);
    if (result == GLBK_OK) result = glbk__leave_created(ctx, glbk_csm_maps_place(ctx, out, NULL, 0));
    if (result != GLBK_OK) glbk_csm_maps_free(ctx, out);
    return result;
}

/* Returns what is kept of the block that begins at a texel, or of the last one that begins before. */
static const glbk__csm_head *glbk__csm_find_head(const glbk_csm_maps *maps, uint32_t start)
{
    const glbk__csm_head *heads = (const glbk__csm_head *)maps->heads;
    uint32_t low = 0, high = maps->block_count, middle;
    while (low + 1 < high) {
        middle = low + (high - low) / 2;
        if (heads[middle].start <= start) low = middle;
        else high = middle;
    }
    return heads + low;
}

/* Returns a word of a block's header, from texel 1 on. */
static uint32_t glbk__csm_head_word(const glbk__csm_head *head, uint32_t word)
{
    return head->words[word - GLBK__CSM_WORD_KEPT];
}

static float glbk__csm_head_float(const glbk__csm_head *head, uint32_t word)
{
    const uint32_t bits = glbk__csm_head_word(head, word);
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

/* Returns the angle that a cell of a domain of directions covers, in radians: no direction is farther from
   that of the map which answers for it, and none farther than half of it where the nearest map answers. 4
   says that no sphere bounds what the maps shadow. */
static float glbk__csm_cell_angle(const glbk__csm_head *head)
{
    const float side = (float)glbk__csm_head_word(head, GLBK__CSM_WORD_SIDE);
    const float a = 6.2832f / side, b = 3.1416f / (float)glbk__csm_head_word(head, GLBK__CSM_WORD_SIDE + 1);
    if (glbk__csm_head_word(head, GLBK__CSM_WORD_SELF_ONLY) & 1u) return 4.0f;
    /* A step in the octahedral square turns a direction by at most 6.2 times its length. */
    if (glbk__csm_head_word(head, GLBK__CSM_WORD_DOMAIN) == COHSM_DOMAIN_OCTAHEDRAL)
        return 6.2f * 1.4143f / side;
    return sqrtf(a * a + b * b);
}

/* Writes the five texels of an instance: world to object, where its block begins and its offset, and what
   cohsm_misses_instance is told of the sphere that holds all that shadows. No hull reaches beyond 1.14 radii;
   a map of a direction reaches to its corners' pixels. */
static void glbk__csm_record(const glbk__csm_head *head, const glbk_csm_instance *instance, uint32_t *words)
{
    const float *transform = glbk_csm__m4_or_identity(instance->transform);
    const float map_side = (float)glbk__csm_head_word(head, GLBK__CSM_WORD_MAP_SIDE);
    float inverse[16], f[20], radius = glbk__csm_head_float(head, GLBK__CSM_WORD_SPHERE + 3), slack;
    glbk_csm__v3 center;
    uint32_t r, c;
    center.x = glbk__csm_head_float(head, GLBK__CSM_WORD_SPHERE);
    center.y = glbk__csm_head_float(head, GLBK__CSM_WORD_SPHERE + 1);
    center.z = glbk__csm_head_float(head, GLBK__CSM_WORD_SPHERE + 2);
    center = glbk_csm__m4_point(transform, center);
    slack = 1e-5f * (fabsf(center.x) + fabsf(center.y) + fabsf(center.z));
    radius *= glbk_csm__v3_length(glbk_csm__v3_load(transform));
    glbk_csm__m4_affine_inverse(inverse, transform);
    for (r = 0; r < 3; r++)
        for (c = 0; c < 4; c++) f[4 * r + c] = inverse[4 * c + r];
    f[13] = instance->offset;
    f[14] = glbk__csm_cell_angle(head);
    f[15] = (1.001f + 2.83f / map_side) * radius + slack;
    glbk_csm__v3_store(f + 16, center);
    f[19] = 1.14f * radius + slack;
    f[12] = 0;
    memcpy(words, f, sizeof f);
    words[12] = instance->start;
}

/* Writes instances and the headers of their blocks into the uniform block. */
static void glbk__csm_place_near(const glbk_csm_maps *maps, const glbk_csm_instance *instances,
                                 uint32_t count, glbk_csm_scene *scene)
{
    uint32_t i;
    for (i = 0; i < count; i++) {
        uint32_t *to = scene->instances + 4 * GLBK__CSM_NEAR_TEXELS * i;
        const glbk__csm_head *head = glbk__csm_find_head(maps, instances[i].start);
        glbk__csm_record(head, &instances[i], to);
        memcpy(to + 4 * GLBK__CSM_RECORD, head->words, sizeof head->words);
    }
}

/* Uploads all instances to their table, at once. */
static glbk_result glbk__csm_place_many(glbk_context *ctx, const glbk_csm_maps *maps,
                                        const glbk_csm_instance *instances, uint32_t count)
{
    glbk_csm__allocator memory = glbk_csm__memory(ctx);
    uint32_t *words = (uint32_t *)glbk_csm__alloc_array(&memory, count, 4 * 4 * GLBK__CSM_RECORD), i;
    glbk_result result;
    if (!words) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i++)
        glbk__csm_record(glbk__csm_find_head(maps, instances[i].start), &instances[i],
                         words + 4 * GLBK__CSM_RECORD * (size_t)i);
    result = glbk__table_update(ctx, &maps->instances, 0, GLBK__CSM_RECORD * (size_t)count, words);
    glbk_csm__free(&memory, words);
    return result;
}

/* Checks what glbk_csm_maps_place is given. */
static glbk_result glbk__csm_check_instances(const glbk_context *ctx, const glbk_csm_maps *maps,
                                             const glbk_csm_instance *instances, uint32_t count)
{
    static const char function[] = "glbk_csm_maps_place";
    const glbk_result bad = GLBK_ERR_INPUT;
    glbk_result result = glbk__require_created(ctx, function, "maps", maps ? &maps->blocks.name : NULL);
    float inverse[16], scale;
    uint32_t i;

    if (result == GLBK_OK && count) result = glbk__require(ctx, function, "instances", instances);
    if (result != GLBK_OK) return result;
    if (count > maps->capacity)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "count", count, 0, maps->capacity);
    for (i = 0; i < count; i++) {
        const float *m = glbk_csm__m4_or_identity(instances[i].transform);
        if (instances[i].start >= maps->texel_count)
            return glbk__refuse_element_value(ctx, bad, function, "instances", i, ".start",
                                              instances[i].start, "one that glbk_csm_maps_create wrote");
        if (!glbk_csm__m4_is_rigid_uniform(m, &scale) || !glbk_csm__m4_affine_inverse(inverse, m))
            return glbk__refuse_element(ctx, bad, function, "instances", i, ".transform",
                                        "is not a rotation, one scale > 0 and a translation");
    }
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_maps_place(glbk_context *ctx, glbk_csm_maps *maps,
                                         const glbk_csm_instance *instances, uint32_t count)
{
    glbk_csm_scene scene;
    glbk_result result;

    result = glbk__csm_check_instances(ctx, maps, instances, count);
    if (result != GLBK_OK) return result;
    memset(&scene, 0, sizeof scene);
    if (maps->near_count) glbk__csm_place_near(maps, instances, count, &scene);
    else if (count) result = glbk__csm_place_many(ctx, maps, instances, count);
    if (result != GLBK_OK) return result;
    maps->count = count;
    scene.count = count;
    scene.in_block = maps->near_count != 0;
    return glbk_buffer_update(ctx, &maps->scene, 0, sizeof scene, &scene);
}

GLBK_DEF void glbk_csm_bind(glbk_context *ctx, const glbk_csm_maps *maps, const glbk_offset *offset)
{
    const glbk_offset at = glbk__offset(offset);
    if (!maps) return;
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_csm_blocks, &maps->blocks);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_csm_instances,
                      maps->instances.name ? &maps->instances : &maps->blocks);
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_csm_scene, &maps->scene);
}

GLBK_DEF void glbk_csm_maps_free(glbk_context *ctx, glbk_csm_maps *maps)
{
    glbk_csm__allocator memory;
    if (!maps) return;
    glbk_texture_free(ctx, &maps->blocks);
    glbk_texture_free(ctx, &maps->instances);
    glbk_buffer_free(ctx, &maps->scene);
    if (maps->heads) {
        memory = glbk_csm__memory(ctx);
        glbk_csm__free(&memory, maps->heads);
    }
    memset(maps, 0, sizeof *maps);
}
