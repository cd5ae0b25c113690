/* ---- gbuffer: creating, uploading, reading ---- */

/* Logs that a field of a desc is bad, and returns the error. */
static glbk_result glbk__gbuffer_bad(const glbk_context *ctx, const char *function, const char *field,
                                     const char *text)
{
    return glbk__refuse(ctx, GLBK_ERR_DESC, function, field, text);
}

/* Returns 1 if a number is within its range, else logs it and returns 0. */
static int glbk__gbuffer_within(const glbk_context *ctx, const char *function, const char *field,
                                double value, double low, double high)
{
    if (value >= low && value <= high) return 1;
    (void)glbk__refuse_range(ctx, GLBK_ERR_DESC, function, field, value, low, high);
    return 0;
}

/* Returns 1 if the numbers of a material and its place are in range, else logs which one is not and returns
   0. */
static int glbk__gbuffer_material_valid(const glbk_context *ctx, const char *function,
                                        const lsamp_material *m, uint32_t plane, float occlusion)
{
    return glbk__gbuffer_within(ctx, function, "material.kind", m->kind, 0, LSAMP_MATERIAL_COUNT - 1) &&
           glbk__gbuffer_within(ctx, function, "material.lobe_count", m->lobe_count, 0, LSAMP_MAX_LOBES) &&
           glbk__gbuffer_within(ctx, function, "plane", plane, 0, 255) &&
           glbk__gbuffer_within(ctx, function, "occlusion", (double)occlusion, 0, 1);
}

/* Returns the kind of a material with the default resolved, as the G-buffer stores it. */
static uint32_t glbk__gbuffer_kind(const lsamp_material *m)
{
    return m->kind == LSAMP_MATERIAL_DEFAULT ? (uint32_t)LSAMP_MATERIAL_LAMBERT : (uint32_t)m->kind;
}

/* Writes the numbers of a material other than its diffuse colour and its lobes, as the texture of gloss has
   them. */
static void glbk__gbuffer_gloss(const lsamp_material *m, float gloss[4])
{
    memset(gloss, 0, 4 * sizeof *gloss);
    if (m->kind == LSAMP_MATERIAL_PHONG) {
        memcpy(gloss, m->specular, sizeof m->specular);
        gloss[3] = m->exponent;
    } else if (m->kind == LSAMP_MATERIAL_METAL_ROUGH) {
        gloss[0] = m->metallic;
        gloss[1] = m->roughness;
    }
}

/* Returns 1 if all `count` numbers are 0. */
static int glbk__gbuffer_is_zero(const float *v, int count)
{
    int i;
    for (i = 0; i < count && v[i] == 0; i++) {}
    return i == count;
}

GLBK__DEF glbk_result glbk__take_attributes(const glbk_context *ctx, const char *function,
                                            const glbk_attributes *from, glbk_attributes *to)
{
    static const char *const names[4] = { "desc.attributes.position", "desc.attributes.normal",
                                          "desc.attributes.uv", "desc.attributes.tangent" };
    int32_t at[4];
    int i, k;
    *to = *from;
    if (from->vertex) return GLBK_OK;       /* which finds its attributes itself */
    if (!from->position && !from->normal && !from->uv && !from->tangent)
        to->normal = 1, to->uv = 2, to->tangent = 3;
    at[0] = to->position;
    at[1] = to->normal;
    at[2] = to->uv;
    at[3] = to->tangent;
    if (at[0] < 0)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, names[0], at[0], 0, 15);
    for (i = 0; i < 4; i++) {
        if (at[i] > 15)
            return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, names[i], at[i], "at most 15");
        for (k = 0; k < i && at[i] >= 0; k++)
            if (at[i] == at[k])
                return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, names[i], at[i],
                                          "used by no other attribute");
    }
    return GLBK_OK;
}

/* Writes defines for a program whose vertex shader has its attributes there. */
static void glbk__write_attributes(const glbk_attributes *at, const char *more,
                                   char defines[GLBK__ATTRIBUTES_ROOM])
{
    static const char *const names[4] = { "GBUFFER_POSITION=", " GBUFFER_NORMAL=", " GBUFFER_UV=",
                                          " GBUFFER_TANGENT=" };
    int32_t locations[4];
    size_t used = 0;
    int i;

    locations[0] = at->position;
    locations[1] = at->normal;
    locations[2] = at->uv;
    locations[3] = at->tangent;
    for (i = 0; i < 4; i++) {
        memcpy(defines + used, names[i], strlen(names[i]));
        used += strlen(names[i]);
        if (locations[i] < 0) defines[used++] = '-';
        if (locations[i] > 9) defines[used++] = '1';
        defines[used++] = (char)(locations[i] < 0 ? '1' : '0' + locations[i] % 10);
    }
    defines[used++] = ' ';
    memcpy(defines + used, more, strlen(more) + 1);
}

GLBK__DEF glbk_result glbk__drawing_program(glbk_context *ctx, const glbk_part *part, const char *name,
                                            const glbk_attributes *at, const char *more, glbk_program *out)
{
    const char *texts[2];
    char defines[GLBK__ATTRIBUTES_ROOM];
    size_t used;
    glbk__write_attributes(at, more, defines);
    used = strlen(defines);
    if (at->vertex) memcpy(defines + used, " GLBK_OWN_VERTEX", 17);
    used = strlen(defines);
    if (at->fragment) memcpy(defines + used, " GLBK_OWN_FRAGMENT", 19);
    texts[0] = at->vertex;
    texts[1] = at->fragment;
    return glbk__program_of_parts(ctx, part, NULL, name, defines, texts, out);
}

/* Makes textures and targets of a G-buffer whose width and height are set. */
static glbk_result glbk__gbuffer_make(glbk_context *ctx, const glbk_gbuffer_desc *d, glbk_gbuffer *out)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result = GLBK_OK;
    int i;

    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    texture.width = out->width;
    texture.height = out->height;
    texture.format = GLBK_FORMAT_RGBA32UI;
    for (i = 0; i < 4 && result == GLBK_OK; i++) {
        result = glbk_texture_create(ctx, &texture, &out->words[i]);
        target.color[i] = &out->words[i];
    }
    if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &out->colors);
    texture.format = GLBK_FORMAT_DEPTH32F;
    out->own_depth = !d->depth;
    if (d->depth) out->depth = *d->depth;
    else if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &out->depth);
    target.depth = &out->depth;
    if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &out->target);
    return result;
}

/* Fills the four textures with zeros, by which nothing is seen anywhere, some rows a call: up to 2^16 pixels,
   1 MB. A call a row takes browsers a tenth of a second. */
static glbk_result glbk__gbuffer_clear_words(glbk_context *ctx, glbk_gbuffer *g)
{
    glbk_gbuf__allocator memory = glbk_gbuf__memory(ctx);
    const uint32_t most = g->width < 65536u ? 65536u / g->width : 1;
    const uint32_t rows = most < g->height ? most : g->height;
    const size_t count = 4 * (size_t)g->width * rows;
    uint32_t *zeros = (uint32_t *)glbk_gbuf__alloc_array(&memory, count, sizeof *zeros), y;
    glbk_result result = zeros ? GLBK_OK : GLBK_ERR_ALLOC;
    int i;
    if (zeros) memset(zeros, 0, count * sizeof *zeros);
    for (i = 0; i < 4; i++)
        for (y = 0; y < g->height && result == GLBK_OK; y += rows) {
            const uint32_t left = g->height - y;
            const glbk_box box = { 0, 0, y, 0, g->width, left < rows ? left : rows, 1 };
            result = glbk_texture_update(ctx, &g->words[i], &box, zeros);
        }
    glbk_gbuf__free(&memory, zeros);
    return result;
}

/* Checks the sizes of a desc. */
static glbk_result glbk__gbuffer_check_desc(const glbk_context *ctx, const char *function,
                                            const glbk_gbuffer_desc *d)
{
    glbk_result result = glbk__require(ctx, function, "desc", d);
    if (result != GLBK_OK) return result;
    result = glbk__require_side(ctx, function, "desc.width", d->width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, function, "desc.height", d->height);
    if (result != GLBK_OK) return result;
    if (d->depth && d->depth->width != d->width)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "desc.depth->width", d->depth->width,
                                  "desc.width");
    if (d->depth && d->depth->height != d->height)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "desc.depth->height", d->depth->height,
                                  "desc.height");
    if (d->depth && (d->depth->format < GLBK_FORMAT_DEPTH24 || d->depth->format > GLBK_FORMAT_DEPTH32F))
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "desc.depth->format",
                                  (double)d->depth->format, "a GLBK_FORMAT_DEPTH...");
    return GLBK_OK;
}

/* Gives a G-buffer, which has no textures, those of a checked desc, in which nothing is seen. */
static glbk_result glbk__gbuffer_fill(glbk_context *ctx, const glbk_gbuffer_desc *d, glbk_gbuffer *out)
{
    glbk_result result;
    out->width = d->width;
    out->height = d->height;
    result = glbk__gbuffer_make(ctx, d, out);
    if (result == GLBK_OK) result = glbk__gbuffer_clear_words(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_gbuffer_create(glbk_context *ctx, const glbk_gbuffer_desc *d, glbk_gbuffer *out)
{
    glbk_result result;
    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result == GLBK_OK) result = glbk__gbuffer_check_desc(ctx, __func__, d);
    if (result != GLBK_OK) return result;
    result = glbk__take_attributes(ctx, __func__, &d->attributes, &out->attributes);
    if (result == GLBK_OK) result = glbk__gbuffer_fill(ctx, d, out);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_gbuffer_drawn), NULL, &out->drawn);
    if (result == GLBK_OK)
        result = glbk_buffer_create(ctx, sizeof(glbk_gbuffer_imported), NULL, &out->imported);
    result = glbk__leave_created(ctx, result);
    if (result != GLBK_OK) glbk_gbuffer_free(ctx, out);
    return result;
}

/* Deletes textures and targets. */
static void glbk__gbuffer_empty(glbk_context *ctx, glbk_gbuffer *g)
{
    int i;
    glbk_target_free(ctx, &g->target);
    glbk_target_free(ctx, &g->colors);
    for (i = 0; i < 4; i++) glbk_texture_free(ctx, &g->words[i]);
    if (g->own_depth) glbk_texture_free(ctx, &g->depth);
}

GLBK_DEF glbk_result glbk_gbuffer_resize(glbk_context *ctx, glbk_gbuffer *g, const glbk_gbuffer_desc *d)
{
    glbk_result result = glbk__require_created(ctx, __func__, "gbuffer", g ? &g->target.name : NULL);
    if (result == GLBK_OK) result = glbk__gbuffer_check_desc(ctx, __func__, d);
    if (result != GLBK_OK) return result;
    glbk__gbuffer_empty(ctx, g);
    g->has_depth = g->has_clip = 0;
    result = glbk__leave_created(ctx, glbk__gbuffer_fill(ctx, d, g));
    if (result != GLBK_OK) glbk_gbuffer_free(ctx, g);
    return result;
}

GLBK_DEF void glbk_gbuffer_free(glbk_context *ctx, glbk_gbuffer *g)
{
    if (!g) return;
    glbk__gbuffer_empty(ctx, g);
    glbk_program_free(ctx, &g->draw_program);
    glbk_program_free(ctx, &g->import_program);
    glbk_buffer_free(ctx, &g->drawn);
    glbk_buffer_free(ctx, &g->imported);
    memset(g, 0, sizeof *g);
}

/* Packs a unit vector into 32 bits as glbk_pack_unit of lib/gbuffer_pack.glsl does, octahedrally; a vector of
   no length becomes 0xffffffff. */
static uint32_t glbk__gbuffer_pack_unit(const float *v)
{
    const float ax = fabsf(v[0]), ay = fabsf(v[1]), sum = ax + ay + fabsf(v[2]);
    float x, y;

    if (!(sum > 0)) return 0xffffffffu;
    x = v[0] / sum;
    y = v[1] / sum;
    if (v[2] < 0) {
        x = (1 - ay / sum) * (v[0] < 0 ? -1.0f : 1.0f);
        y = (1 - ax / sum) * (v[1] < 0 ? -1.0f : 1.0f);
    }
    x = (x * 0.5f + 0.5f) * 65534.0f + 0.5f;
    y = (y * 0.5f + 0.5f) * 65534.0f + 0.5f;
    return (uint32_t)(x > 0 ? x : 0) | (uint32_t)(y > 0 ? y : 0) << 16;
}

/* Unpacks what glbk__gbuffer_pack_unit packed; 0xffffffff becomes a vector of no length. */
static void glbk__gbuffer_unpack_unit(uint32_t bits, float *v)
{
    float x = (float)(bits & 0xffffu) * (2.0f / 65534.0f) - 1;
    float y = (float)(bits >> 16) * (2.0f / 65534.0f) - 1;
    float z = 1 - fabsf(x) - fabsf(y), t = z < 0 ? -z : 0, size;

    memset(v, 0, 3 * sizeof *v);
    if (bits == 0xffffffffu) return;
    x += x < 0 ? t : -t;
    y += y < 0 ? t : -t;
    size = sqrtf(x * x + y * y + z * z);
    v[0] = x / size;
    v[1] = y / size;
    v[2] = z / size;
}

/* Writes the four words of each texture for one pixel. Where its normal is 0 or not finite, nothing is
   seen. */
static void glbk__gbuffer_words(const glbk_pixel *p, uint32_t words[4][4])
{
    const lsamp_material *m = &p->material;
    const float *n = p->normal;
    const float d = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    const float shade = p->occlusion > 0 ? p->occlusion < 1 ? p->occlusion : 1.0f : 0.0f;
    float gloss[4];

    memset(words, 0, 16 * sizeof words[0][0]);
    if (!(d > 0 && d < 3e38f)) return;
    memcpy(words[0], p->position, 12);
    words[0][3] = p->entity;
    memcpy(words[1], n, 12);
    words[1][3] = glbk__gbuffer_kind(m) | (p->plane & 255u) << 8 | (uint32_t)(shade * 65535.0f + 0.5f) << 16;
    memcpy(words[2], m->diffuse, 12);
    words[2][3] =
        glbk__gbuffer_pack_unit(glbk__gbuffer_is_zero(p->geometric_normal, 3) ? n : p->geometric_normal);
    glbk__gbuffer_gloss(m, gloss);
    memcpy(words[3], gloss, sizeof gloss);
    if (m->kind != LSAMP_MATERIAL_LAFORTUNE) return;
    words[3][0] = p->first_lobe;
    words[3][1] = m->lobe_count;
    words[3][2] = glbk__gbuffer_pack_unit(p->tangent);
}

/* Reads back what glbk__gbuffer_words wrote. */
static void glbk__gbuffer_pixel(uint32_t words[4][4], glbk_pixel *p)
{
    lsamp_material *m = &p->material;
    float gloss[4];

    memset(p, 0, sizeof *p);
    if (!(words[1][3] & 255u)) return;
    memcpy(p->position, words[0], 12);
    p->entity = words[0][3];
    memcpy(p->normal, words[1], 12);
    m->kind = (lsamp_material_kind)(words[1][3] & 255u);
    p->plane = words[1][3] >> 8 & 255u;
    p->occlusion = (float)(words[1][3] >> 16) / 65535.0f;
    memcpy(m->diffuse, words[2], 12);
    glbk__gbuffer_unpack_unit(words[2][3], p->geometric_normal);
    memcpy(gloss, words[3], sizeof gloss);
    if (m->kind == LSAMP_MATERIAL_PHONG) {
        memcpy(m->specular, gloss, sizeof m->specular);
        m->exponent = gloss[3];
    } else if (m->kind == LSAMP_MATERIAL_METAL_ROUGH) {
        m->metallic = gloss[0];
        m->roughness = gloss[1];
    } else if (m->kind == LSAMP_MATERIAL_LAFORTUNE) {
        p->first_lobe = words[3][0];
        m->lobe_count = words[3][1];
        glbk__gbuffer_unpack_unit(words[3][2], p->tangent);
    }
}

/* The words of some rows on their way: texture k has those of pixel i from words + 4 (k count + i) on. */
typedef struct glbk__gbuffer_rows {
    glbk_gbuf__allocator memory;
    size_t    count;                /* pixels */
    uint32_t *words;
} glbk__gbuffer_rows;

/* Checks the arguments of an upload or a reading and gets memory for its words, which glbk_gbuf__free
   frees. */
static glbk_result glbk__gbuffer_take_rows(const glbk_context *ctx, const char *function,
                                           const glbk_gbuffer *g, uint32_t row, uint32_t row_count,
                                           const glbk_pixel *pixels, glbk__gbuffer_rows *out)
{
    const glbk_result bad = GLBK_ERR_ARGUMENT;
    glbk_result result = glbk__require_created(ctx, function, "gbuffer", g ? &g->colors.name : NULL);
    if (result == GLBK_OK) result = glbk__require(ctx, function, "pixels", pixels);
    if (result != GLBK_OK) return result;
    if (row >= g->height)
        return glbk__refuse_range(ctx, bad, function, "row", row, 0, g->height - 1.0);
    if (!row_count || row_count > g->height - row)
        return glbk__refuse_range(ctx, bad, function, "row_count", row_count, 1, g->height - row);
    out->memory = glbk_gbuf__memory(ctx);
    out->count = (size_t)g->width * row_count;
    out->words = (uint32_t *)glbk_gbuf__alloc_array(&out->memory, out->count, 64);
    return out->words ? GLBK_OK : GLBK_ERR_ALLOC;
}

/* Checks that a vector of pixel i is unit, 0 0 0, or not finite (src/README.md). */
static glbk_result glbk__gbuffer_check_unit(const glbk_context *ctx, size_t i, const char *member,
                                            const float *v)
{
    const float square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (glbk_gbuf__is_unit2(square) || !(square > 0 && square <= 3e38f)) return GLBK_OK;
    return glbk__refuse_element_value(ctx, GLBK_ERR_INPUT, "glbk_gbuffer_upload", "pixels", i, member,
                                      (double)sqrtf(square), "0.97..1.03, or 0");
}

/* Checks the vectors of pixels. */
static glbk_result glbk__gbuffer_check_pixels(const glbk_context *ctx, const glbk_pixel *pixels, size_t count)
{
    glbk_result result = GLBK_OK;
    size_t i;
    for (i = 0; i < count && result == GLBK_OK; i++) {
        result = glbk__gbuffer_check_unit(ctx, i, ".normal: its length", pixels[i].normal);
        if (result == GLBK_OK)
            result = glbk__gbuffer_check_unit(ctx, i, ".geometric_normal: its length",
                                              pixels[i].geometric_normal);
        if (result == GLBK_OK)
            result = glbk__gbuffer_check_unit(ctx, i, ".tangent: its length", pixels[i].tangent);
    }
    return result;
}

GLBK_DEF glbk_result glbk_gbuffer_upload(glbk_context *ctx, glbk_gbuffer *g, uint32_t row, uint32_t row_count,
                                         const glbk_pixel *pixels)
{
    glbk__gbuffer_rows rows;
    uint32_t pixel[4][4], k;
    glbk_result result = glbk__gbuffer_take_rows(ctx, __func__, g, row, row_count, pixels, &rows);
    glbk_box box = { 0, 0, 0, 0, 0, 0, 1 };
    size_t i;

    if (result != GLBK_OK) return result;
    box.y = row;
    box.width = g->width;
    box.height = row_count;
    result = glbk__gbuffer_check_pixels(ctx, pixels, rows.count);
    for (i = 0; i < rows.count && result == GLBK_OK; i++) {
        glbk__gbuffer_words(&pixels[i], pixel);
        for (k = 0; k < 4; k++) memcpy(rows.words + 4 * (k * rows.count + i), pixel[k], sizeof pixel[k]);
    }
    for (k = 0; k < 4 && result == GLBK_OK; k++)
        result = glbk_texture_update(ctx, &g->words[k], &box, rows.words + 4 * k * rows.count);
    glbk_gbuf__free(&rows.memory, rows.words);
    if (result == GLBK_OK) g->has_depth = g->has_clip = 0;
    return result;
}

GLBK_DEF glbk_result glbk_gbuffer_read(glbk_context *ctx, const glbk_gbuffer *g, uint32_t row,
                                       uint32_t row_count, glbk_pixel *pixels)
{
    glbk__gbuffer_rows rows;
    uint32_t pixel[4][4], k;
    glbk_result result = glbk__gbuffer_take_rows(ctx, __func__, g, row, row_count, pixels, &rows);
    size_t i;

    if (result != GLBK_OK) return result;
    for (k = 0; k < 4 && result == GLBK_OK; k++)
        result = glbk_target_read(ctx, &g->colors, k, 0, row, g->width, row_count,
                                  rows.words + 4 * k * rows.count);
    for (i = 0; i < rows.count && result == GLBK_OK; i++) {
        for (k = 0; k < 4; k++) memcpy(pixel[k], rows.words + 4 * (k * rows.count + i), sizeof pixel[k]);
        glbk__gbuffer_pixel(pixel, &pixels[i]);
    }
    glbk_gbuf__free(&rows.memory, rows.words);
    return result;
}

GLBK_DEF glbk_result glbk_gbuffer_bind(glbk_context *ctx, const glbk_gbuffer *g, const glbk_offset *offset)
{
    const uint32_t first = GLBK_SLOT_glbk_gbuffer_place + glbk__offset(offset).unit;
    const glbk_result result = glbk__require_created(ctx, __func__, "gbuffer", g ? &g->colors.name : NULL);
    uint32_t i;
    if (result != GLBK_OK) return result;
    for (i = 0; i < 4; i++) glbk_bind_texture(ctx, first + i, &g->words[i]);
    return GLBK_OK;
}

GLBK__DEF glbk_result glbk__gbuffer_program_with(glbk_context *ctx, const glbk_part *part, const char *name,
                                                 const char *defines, const char *const texts[2],
                                                 glbk_program *out)
{
    const glbk_part *const others[2] = { &glbk__gbuffer_reader, NULL };
    return glbk__program_of_parts(ctx, part, others, name, defines, texts, out);
}

GLBK__DEF glbk_result glbk__gbuffer_program_above(glbk_context *ctx, const glbk_part *part,
                                                  const glbk_part *under, const char *name,
                                                  const char *defines, glbk_program *out)
{
    const glbk_part *const others[2] = { &glbk__gbuffer_reader, under };
    return glbk__program_of_parts(ctx, part, others, name, defines, NULL, out);
}

GLBK__DEF glbk_result glbk__gbuffer_program(glbk_context *ctx, const glbk_part *part, const char *name,
                                            const char *defines, glbk_program *out)
{
    return glbk__gbuffer_program_with(ctx, part, name, defines, NULL, out);
}
