/* ---- sfield: fields: files of shadowfield.h as texels of one table ---- */

enum { GLBK__SFIELD_KERNELS = 24 * 48 * 6 };    /* of the table of sfield_sh_brdf */

static const uint32_t glbk__sfield_none = 0xffffffffu;  /* SFIELD_NONE of the GLSL */

/* Writes the name of an element of a call's arguments, as the log has it: "ARRAY[INDEX]FIELD". field: "" or
   ".NAME". Returns the name's text. */
static const char *glbk__sfield_name(glbk_sfield__message *name, const char *array, size_t index,
                                     const char *field)
{
    name->used = 0;
    glbk_sfield__message_text(name, array);
    glbk_sfield__message_text(name, "[");
    glbk_sfield__message_count(name, index);
    glbk_sfield__message_text(name, "]");
    glbk_sfield__message_text(name, field);
    return name->text;
}

GLBK__DEF glbk_result glbk__sfield_check_scene(const glbk_context *ctx, const char *function,
                                               const glbk_sfield_scene *s)
{
    if (s && s->table.name) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "scene", s ? "was not created" : "is NULL");
}

/* Appends a number. */
static void glbk__sfield_number(glbk__sink *sink, uint32_t n)
{
    char digits[12];
    size_t at = sizeof digits;
    do digits[--at] = (char)('0' + n % 10);
    while ((n /= 10) != 0);
    glbk__append(sink, digits + at, sizeof digits - at);
}

/* Returns the bands of an algebra, or 0 without one. */
static uint32_t glbk__sfield_bands(const sfield_algebra *algebra)
{
    static const float upright[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    sfield_rotation rotation;
    return sfield_sh_rotation(algebra, upright, &rotation) == SFIELD_OK ? rotation.bands : 0;
}

/* Returns how many texels a rotation has: rows of the blocks from the second band on, each filled up to a
   multiple of four numbers. */
static uint32_t glbk__sfield_rotation_texels(uint32_t bands)
{
    uint32_t l, n = 0;
    for (l = 1; l < bands; l++) n += (2 * l + 1) * ((2 * l + 4) / 4);
    return n;
}

/* Returns how many texels an entity and its rotation have. */
static uint32_t glbk__sfield_entity_texels(uint32_t bands)
{
    return GLBK__SFIELD_ENTITY + glbk__sfield_rotation_texels(bands);
}

/* Returns the little-endian number at p; glbk__sfield_float returns a float. */
static uint32_t glbk__sfield_word(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static float glbk__sfield_float(const uint8_t *p)
{
    const uint32_t word = glbk__sfield_word(p);
    float x;
    memcpy(&x, &word, 4);
    return x;
}

/* Returns how many texels a field has: for its head, its shells, scales and biases for each channel of a
   shell and frame, and samples. */
static uint64_t glbk__sfield_texels_of(const sfield_info *info)
{
    const uint32_t channels = info->kind == SFIELD_KIND_SOURCE ? 3 : 1,
                   cells = (info->bands * info->bands + 15) / 16;
    const uint64_t groups = (uint64_t)info->frame_count * info->shell_count;
    return 3 + info->shell_count + (groups * 8 + info->sample_count) * channels * cells;
}

GLBK__DEF void glbk__sfield_read(const uint8_t *bytes, glbk__sfield_view *v)
{
    size_t groups;
    v->bytes = bytes;
    v->kind = glbk__sfield_word(bytes + 16);
    v->bands = glbk__sfield_word(bytes + 28);
    v->shells = glbk__sfield_word(bytes + 36);
    v->side = glbk__sfield_word(bytes + 40);
    v->spacing = glbk__sfield_word(bytes + 44);
    v->frames = glbk__sfield_word(bytes + 48);
    v->loop = glbk__sfield_word(bytes + 52);
    v->channels = glbk__sfield_word(bytes + 56);
    v->samples = glbk__sfield_word(bytes + 60);
    v->stride = glbk__sfield_word(bytes + 64);
    v->cells = (v->bands * v->bands + 15) / 16;
    groups = (size_t)v->frames * v->shells;
    v->scales = 4 * (GLBK__SFIELD_HEADER + (size_t)v->shells);
    v->first = v->scales + 8 * groups * v->stride;
}

GLBK__DEF void glbk__sfield_flush(glbk__sfield_stage *s)
{
    if (s->count && s->result == GLBK_OK)
        s->result = glbk__table_update(s->ctx, s->table, s->at, s->count, s->words);
    s->at += s->count;
    s->count = 0;
}

GLBK__DEF uint32_t *glbk__sfield_texel(glbk__sfield_stage *s)
{
    if (s->count == s->room) glbk__sfield_flush(s);
    return (uint32_t *)memset(s->words + 4 * s->count++, 0, 16);
}

/* Writes the scales, or the biases, of one channel of a shell and frame. */
static void glbk__sfield_put_floats(glbk__sfield_stage *s, const glbk__sfield_view *v, const uint8_t *from)
{
    uint32_t k, *texel = NULL;
    for (k = 0; k < 16 * v->cells; k++) {
        if (k % 4 == 0) texel = glbk__sfield_texel(s);
        if (k < v->bands * v->bands) texel[k % 4] = glbk__sfield_word(from + 4 * (size_t)k);
    }
}

GLBK__DEF float glbk__sfield_measure(float d2, int source, int uniform)
{
    float inverse = 1 / d2, u = inverse < 1 ? inverse : 1;
    if (uniform) return -sqrtf(d2);
    return source || d2 < 1 ? inverse : u / (1 + sqrtf(1 - u));
}

/* Writes the texels of a field. */
static void glbk__sfield_put(glbk__sfield_stage *s, const glbk__sfield_view *v)
{
    const uint32_t step = v->stride / v->channels, groups = v->frames * v->shells;
    uint32_t *texel = glbk__sfield_texel(s), i, c, k;
    float pair[2];
    texel[0] = (v->kind ? 1u : 0u) | (v->spacing == SFIELD_SPACING_UNIFORM ? 2u : 0u) | (v->loop ? 4u : 0u);
    texel[1] = v->frames;
    texel[2] = v->shells;
    texel[3] = v->side;
    texel = glbk__sfield_texel(s);
    texel[0] = v->channels;
    texel[1] = 3 + v->shells;
    texel[2] = texel[1] + groups * v->channels * v->cells * 8;
    texel = glbk__sfield_texel(s);
    texel[0] = glbk__sfield_word(v->bytes + 92);
    for (i = 0; i < v->shells; i++) {
        pair[0] = glbk__sfield_float(v->bytes + 4 * (GLBK__SFIELD_HEADER + (size_t)i));
        pair[0] *= pair[0];
        pair[1] = glbk__sfield_measure(pair[0], v->kind == 1, v->spacing == SFIELD_SPACING_UNIFORM);
        memcpy(glbk__sfield_texel(s), pair, sizeof pair);
    }
    for (i = 0; i < groups; i++)
        for (c = 0; c < v->channels; c++)
            for (k = 0; k < 2; k++)
                glbk__sfield_put_floats(
                    s, v, v->bytes + v->scales + 4 * (((size_t)k * groups + i) * v->stride + c * step));
    for (i = 0; i < v->samples; i++)
        for (c = 0; c < v->channels; c++) {
            const uint8_t *from = v->bytes + v->first + (size_t)i * v->stride + c * step;
            for (k = 0; k < 16 * v->cells; k++) {
                if (k % 16 == 0) texel = glbk__sfield_texel(s);
                if (k < v->bands * v->bands) texel[k / 4 % 4] |= (uint32_t)from[k] << k % 4 * 8;
            }
        }
}

/* Returns the terms of the product in memory of their own, as sfield_sh_terms writes them, or NULL without
   memory. */
static uint32_t *glbk__sfield_terms(const glbk_sfield__allocator *memory, const sfield_algebra *algebra,
                                    uint32_t *count)
{
    const size_t terms = sfield_sh_terms(algebra, NULL, NULL);
    uint32_t *out = (uint32_t *)glbk_sfield__alloc_array(memory, terms + 1, 8);
    if (out) (void)sfield_sh_terms(algebra, out, (float *)(void *)(out + terms));
    *count = (uint32_t)terms;
    return out;
}

/* Writes the terms of the product, two a texel. */
static void glbk__sfield_put_terms(glbk__sfield_stage *s, const uint32_t *terms, uint32_t count)
{
    uint32_t i, *texel = NULL;
    for (i = 0; i < count; i++) {
        float c;
        memcpy(&c, terms + count + i, 4);
        if ((terms[i] & 255u) == (terms[i] >> 8 & 255u)) c *= 0.5f;     /* since a_i b_j + a_j b_i counts it
                                                                           twice */
        if (i % 2 == 0) texel = glbk__sfield_texel(s);
        texel[i % 2 * 2] = terms[i];
        memcpy(texel + i % 2 * 2 + 1, &c, 4);
    }
    for (i = (i + 1) / 2; i % 4; i++) (void)glbk__sfield_texel(s);      /* fills up with terms of factor 0 to
                                                                           a multiple of 4 texels */
}

/* Returns how many texels a scene's table of BRDFs has. */
static uint32_t glbk__sfield_brdf_texels(const glbk_sfield_scene_desc *d, uint32_t bands)
{
    return d->brdf ? GLBK__SFIELD_KERNELS * ((bands * (bands + 1) / 2 + 3) / 4) : 0;
}

/* Writes the table of BRDFs, each kernel filled up to a multiple of four numbers. */
static void glbk__sfield_put_brdf(glbk__sfield_stage *s, const float *table, uint32_t bands)
{
    const uint32_t half = bands * (bands + 1) / 2;
    uint32_t i, k, *texel = NULL;
    for (i = 0; i < GLBK__SFIELD_KERNELS; i++)
        for (k = 0; k < half; k++) {
            if (k % 4 == 0) texel = glbk__sfield_texel(s);
            memcpy(texel + k % 4, table++, 4);
        }
}

/* Returns whether the first occlusion field of a desc holds logarithms, as all then do. */
static int glbk__sfield_logarithms(const glbk_sfield_scene_desc *d)
{
    size_t i;
    for (i = 0; i < d->field_count; i++) {
        sfield_info info;
        if (!d->fields[i]) continue;
        sfield_get_info(d->fields[i], &info);
        if (info.kind == SFIELD_KIND_OCCLUSION && info.basis == SFIELD_BASIS_SH) return info.logarithm;
    }
    return 0;
}

/* Returns why the GPU cannot have a field of this kind, or NULL if it can. */
static const char *glbk__sfield_refuse(const sfield_info *info, uint32_t bands, int logarithms)
{
    if (info->kind != SFIELD_KIND_OCCLUSION && info->kind != SFIELD_KIND_SOURCE)
        return "is neither an occlusion nor a source field";
    if (info->basis != SFIELD_BASIS_SH)
        return "is one of wavelets, which glbk_sfield_haar_upload takes";
    if (info->bands != bands) return "has other bands than desc.algebra";
    if (info->kind == SFIELD_KIND_OCCLUSION && !info->logarithm != !logarithms)
        return info->logarithm ? "is one of logarithms, as others are not"
                               : "is none of logarithms, as others are";
    return info->shard_end ? "is a shard: sfield_merge first" : NULL;
}

GLBK__DEF glbk_result glbk__sfield_check_lists(const glbk_context *ctx, const char *function,
                                               const sfield_field *const *fields, size_t field_count,
                                               uint32_t entity_capacity, float reach)
{
    if (field_count && !fields) return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.fields", "is NULL");
    if (!entity_capacity || entity_capacity > 65535)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.entity_capacity", entity_capacity, 1,
                                  65535);
    if (!(reach >= 0 && reach <= 1e6f))
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.reach", (double)reach, 0, 1e6);
    return GLBK_OK;
}

/* Checks the desc of glbk_sfield_scene_create. */
static glbk_result glbk__sfield_check(const glbk_context *ctx, const char *function,
                                      const glbk_sfield_scene_desc *d, uint32_t bands)
{
    glbk_sfield__message name;
    glbk_result result;
    size_t i;
    if (!d->algebra) return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.algebra", "is NULL");
    result = glbk__sfield_check_lists(ctx, function, d->fields, d->field_count, d->entity_capacity, d->reach);
    if (result != GLBK_OK) return result;
    for (i = 0; i < d->field_count; i++) {
        sfield_info info;
        const char *why = "is NULL";
        if (d->fields[i]) {
            sfield_get_info(d->fields[i], &info);
            why = glbk__sfield_refuse(&info, bands, glbk__sfield_logarithms(d));
        }
        if (why)
            return glbk__refuse(ctx, d->fields[i] ? GLBK_ERR_MISMATCH : GLBK_ERR_DESC, function,
                                glbk__sfield_name(&name, "desc.fields", i, ""), why);
    }
    return GLBK_OK;
}

GLBK__DEF int glbk__sfield_by_pointer(const void *a, const void *b)
{
    const uintptr_t x = (uintptr_t)((const glbk_sfield_field *)a)->field;
    const uintptr_t y = (uintptr_t)((const glbk_sfield_field *)b)->field;
    return (x > y) - (x < y);
}

/* Says of each field where it begins, and raises *most_bytes to the bytes of the longest file. Returns the
   texels of all. */
static uint64_t glbk__sfield_lay_out(const glbk_sfield_scene_desc *d, uint64_t texels,
                                     glbk_sfield_field *fields, size_t *most_bytes)
{
    size_t i;
    for (i = 0; i < d->field_count && texels <= (uint64_t)1 << 28; i++) {
        sfield_info info;
        sfield_get_info(d->fields[i], &info);
        fields[i].field = d->fields[i];
        fields[i].start = (uint32_t)texels;
        fields[i].source = info.kind == SFIELD_KIND_SOURCE;
        memcpy(fields[i].center, info.center, sizeof info.center);
        fields[i].radius = info.radius;
        fields[i].inscribed = info.inscribed;
        fields[i].outer = info.outer;
        texels += glbk__sfield_texels_of(&info);
        if (info.bytes > *most_bytes) *most_bytes = info.bytes;
    }
    return texels;
}

/* Uploads terms, BRDFs and fields, these by way of the bytes of each field's file. */
static glbk_result glbk__sfield_fill(const glbk_sfield_scene_desc *d, uint32_t bands,
                                     const glbk_sfield__allocator *memory, size_t most_bytes,
                                     glbk__sfield_stage *s)
{
    uint32_t count, *terms = glbk__sfield_terms(memory, d->algebra, &count);
    uint8_t *bytes = (uint8_t *)glbk_sfield__alloc(memory, most_bytes + 1);
    glbk__sfield_view v;
    size_t i;
    s->words = (uint32_t *)glbk_sfield__alloc(memory, 16 * GLBK__SFIELD_STAGE);
    s->room = GLBK__SFIELD_STAGE;
    if (!terms || !bytes || !s->words) s->result = GLBK_ERR_ALLOC;
    else {
        glbk__sfield_put_terms(s, terms, count);
        if (d->brdf) glbk__sfield_put_brdf(s, d->brdf, bands);
        for (i = 0; i < d->field_count && s->result == GLBK_OK; i++) {
            (void)sfield_write(d->fields[i], bytes, most_bytes);
            glbk__sfield_read(bytes, &v);
            glbk__sfield_put(s, &v);
        }
        glbk__sfield_flush(s);
    }
    glbk_sfield__free(memory, s->words);
    glbk_sfield__free(memory, bytes);
    glbk_sfield__free(memory, terms);
    return s->result;
}

static glbk_result glbk__sfield_put_quarter(glbk_context *ctx, const glbk_sfield_scene *s);

/* Makes the tables of a scene whose bands, entity_capacity, reach and algebra are set. */
static glbk_result glbk__sfield_create(glbk_context *ctx, const char *function,
                                       const glbk_sfield_scene_desc *d, glbk_sfield_scene *out)
{
    const glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
    const uint64_t most = (uint64_t)1 << 28;
    uint64_t texels, moving;
    size_t most_bytes = 0;
    glbk__sfield_stage s;

    out->terms = ((uint32_t)sfield_sh_terms(d->algebra, NULL, NULL) + 7) / 8 * 4;
    out->has_brdf = d->brdf != NULL;
    out->logarithms = glbk__sfield_logarithms(d);
    out->entities_at = out->bands * out->bands;
    if (d->brdf) out->entities_at += glbk__sfield_rotation_texels(out->bands);
    moving = out->entities_at + (uint64_t)d->entity_capacity * glbk__sfield_entity_texels(out->bands);
    out->fields =
        (glbk_sfield_field *)glbk_sfield__alloc_array(&memory, d->field_count + 1, sizeof *out->fields);
    if (!out->fields) return GLBK_ERR_ALLOC;
    out->field_count = d->field_count;
    texels = glbk__sfield_lay_out(d, out->terms + glbk__sfield_brdf_texels(d, out->bands), out->fields,
                                  &most_bytes);
    if (texels > most || moving > most)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function,
                                  texels > most ? "the number of texels of desc.fields"
                                                : "the number of texels of desc.entity_capacity",
                                  (double)(texels > most ? texels : moving), 0, (double)most);
    qsort(out->fields, d->field_count, sizeof *out->fields, glbk__sfield_by_pointer);
    out->texels = (uint32_t)texels;
    memset(&s, 0, sizeof s);
    s.ctx = ctx;
    s.table = &out->table;
    s.result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, out->texels + (size_t)1, &out->table);
    if (s.result == GLBK_OK)
        s.result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, (size_t)moving, &out->moving);
    if (s.result == GLBK_OK)
        s.result = glbk_buffer_create(ctx, sizeof(glbk_sfield_contents), NULL, &out->contents);
    if (s.result == GLBK_OK) s.result = glbk__sfield_fill(d, out->bands, &memory, most_bytes, &s);
    if (s.result == GLBK_OK && d->brdf) s.result = glbk__sfield_put_quarter(ctx, out);
    return s.result == GLBK_OK ? glbk__leave_created(ctx, glbk_sfield_scene_sky(ctx, out, NULL)) : s.result;
}

GLBK_DEF glbk_result glbk_sfield_scene_create(glbk_context *ctx, const glbk_sfield_scene_desc *d,
                                              glbk_sfield_scene *out)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    if (!d) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "desc", "is NULL");
    out->bands = glbk__sfield_bands(d->algebra);
    result = glbk__sfield_check(ctx, __func__, d, out->bands);
    out->algebra = d->algebra;
    out->entity_capacity = d->entity_capacity;
    out->reach = d->reach;
    if (result == GLBK_OK) result = glbk__sfield_create(ctx, __func__, d, out);
    if (result != GLBK_OK) glbk_sfield_scene_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_sfield_scene_free(glbk_context *ctx, glbk_sfield_scene *s)
{
    if (!s) return;
    glbk_texture_free(ctx, &s->table);
    glbk_texture_free(ctx, &s->moving);
    glbk_buffer_free(ctx, &s->contents);
    if (ctx) {
        const glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
        glbk_sfield__free(&memory, s->fields);
    }
    memset(s, 0, sizeof *s);
}
