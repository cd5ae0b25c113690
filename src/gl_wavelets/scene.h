/* ---- wavelets: scenes ---- */

enum { GLBK__HAAR_IS_SELF = 2 };        /* a kind of glbk_sfield_field.source */

/* Writes the first texels of a field, up to its roots. Those of harmonics have the same places. */
static void glbk__haar_head(glbk__sfield_stage *s, const glbk__sfield_view *v)
{
    const uint32_t first = (uint32_t)(s->at + s->count);
    uint32_t *texel = glbk__sfield_texel(s), i;
    float pair[2];
    texel[0] = (v->kind == 1 ? 1u : 0u) | (v->spacing == SFIELD_SPACING_UNIFORM ? 2u : 0u);
    texel[0] |= v->loop ? 4u : 0u;
    texel[1] = v->frames;
    texel[2] = v->shells;
    texel[3] = v->side;
    texel = glbk__sfield_texel(s);
    texel[0] = v->channels > 1 ? 2 : 1;
    texel[1] = first + 3 + v->shells;
    texel = glbk__sfield_texel(s);
    texel[0] = glbk_haar__get_u32(v->bytes + 92);
    for (i = 0; i < v->shells; i++) {
        pair[0] = glbk_haar__get_f32(v->bytes + 4 * (GLBK__SFIELD_HEADER + (size_t)i));
        pair[0] *= pair[0];
        pair[1] = glbk__sfield_measure(pair[0], v->kind == 1, v->spacing == SFIELD_SPACING_UNIFORM);
        memcpy(glbk__sfield_texel(s), pair, sizeof pair);
    }
}

/* Returns why a scene of wavelets cannot have a field, or NULL if it can. */
static const char *glbk__haar_refuse(const sfield_info *info, uint32_t side)
{
    if (info->basis != SFIELD_BASIS_HAAR) return "is one of harmonics, which glbk_sfield_scene_create takes";
    if (info->cube_side != side) return "has another cube_side than desc.cube_side";
    return info->shard_end ? "is a shard: sfield_merge first" : NULL;
}

static glbk_result glbk__haar_check(const glbk_context *ctx, const char *function,
                                    const glbk_sfield_haar_scene_desc *d, uint32_t side)
{
    glbk_result result;
    size_t i;
    if (side < 4 || side > 64 || (side & (side - 1)))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.cube_side", side,
                                  "a power of two within 4..64, or 0");
    result = glbk__sfield_check_lists(ctx, function, d->fields, d->field_count, d->entity_capacity, d->reach);
    if (result != GLBK_OK) return result;
    for (i = 0; i < d->field_count; i++) {
        sfield_info info;
        const char *why = "is NULL";
        if (d->fields[i]) {
            sfield_get_info(d->fields[i], &info);
            why = glbk__haar_refuse(&info, side);
        }
        if (why)
            return glbk__refuse_element(ctx, d->fields[i] ? GLBK_ERR_MISMATCH : GLBK_ERR_DESC, function,
                                        "desc.fields", i, "", why);
    }
    return GLBK_OK;
}

/* What making a scene of wavelets needs for a while. */
typedef struct glbk__haar_nursery {
    const glbk_sfield_haar_scene_desc *d;
    glbk__haar_tree *tree;
    uint8_t  *bytes;                    /* of the file of a field */
    size_t    most_bytes;
    uint64_t  texels;                   /* so far */
    int       lists;                    /* not 0: fields go up as lists, not as trees */
    glbk__sfield_stage roots, nodes;
} glbk__haar_nursery;

/* Reads field i, and says of the scene's entry where it begins. Returns the lists. */
static glbk__haar_lists glbk__haar_open(glbk__haar_nursery *n, size_t i, glbk__sfield_view *v)
{
    (void)sfield_write(n->d->fields[i], n->bytes, n->most_bytes);
    glbk__sfield_read(n->bytes, v);
    v->scales = 4 * (GLBK__SFIELD_HEADER + (size_t)v->shells);
    n->tree->channels = v->channels;
    return glbk__haar_lists_of(n->bytes, v);
}

/* Returns how many texels come before the nodes of a field's trees but the roots, or before the entries of
   its lists. */
static uint64_t glbk__haar_first(const glbk__haar_nursery *n, const glbk__sfield_view *v)
{
    const uint32_t step = v->channels > 1 ? 2 : 1;
    return 3 + v->shells + (n->lists ? 1 : 6 * step) * (uint64_t)v->samples;
}

/* Finds where all fields begin, and where they end. */
static void glbk__haar_lay_out(glbk__haar_nursery *n, glbk_sfield_field *fields)
{
    size_t i;
    for (i = 0; i < n->d->field_count && n->texels <= (uint64_t)1 << 28; i++) {
        glbk__sfield_view v;
        const glbk__haar_lists l = glbk__haar_open(n, i, &v);
        const uint64_t rest = n->lists ? glbk__haar_copy(n->tree, &l, NULL, NULL)
                                       : (v.channels > 1 ? 2 : 1) * glbk__haar_trees(n->tree, &l, NULL, NULL);
        sfield_info info;
        sfield_get_info(n->d->fields[i], &info);
        fields[i].field = n->d->fields[i];
        fields[i].start = (uint32_t)n->texels;
        fields[i].source = info.kind == SFIELD_KIND_SOURCE      ? 1
                           : info.kind == SFIELD_KIND_OCCLUSION ? 0
                                                                : GLBK__HAAR_IS_SELF;
        memcpy(fields[i].center, info.center, sizeof info.center);
        fields[i].radius = info.radius;
        fields[i].inscribed = info.inscribed;
        fields[i].outer = info.outer;
        n->texels += glbk__haar_first(n, &v) + rest;
    }
}

/* Uploads all fields. */
static glbk_result glbk__haar_fill(glbk__haar_nursery *n, const glbk_sfield_field *fields)
{
    size_t i;
    for (i = 0; i < n->d->field_count && n->roots.result == GLBK_OK; i++) {
        glbk__sfield_view v;
        const glbk__haar_lists l = glbk__haar_open(n, i, &v);
        n->roots.at = fields[i].start;
        n->nodes.at = fields[i].start + (size_t)glbk__haar_first(n, &v);
        glbk__haar_head(&n->roots, &v);
        if (n->lists) (void)glbk__haar_copy(n->tree, &l, &n->roots, &n->nodes);
        else (void)glbk__haar_trees(n->tree, &l, &n->roots, &n->nodes);
        glbk__sfield_flush(&n->roots);
        glbk__sfield_flush(&n->nodes);
        if (n->roots.result == GLBK_OK) n->roots.result = n->nodes.result;
    }
    return n->roots.result;
}

/* Returns a number for where a scene's fields begin and end in its table, never 0. Scenes of one number have
   the self-visibilities of each other: a field made anew at an old one's address has another size. */
static uint64_t glbk__haar_key(const glbk_sfield_scene *s)
{
    uint64_t key = s->texels;
    size_t i;
    for (i = 0; i < s->field_count; i++)
        key = (key ^ ((uint64_t)(uintptr_t)s->fields[i].field << 8 ^ s->fields[i].start)) * 1099511628211u;
    return key | 1;
}

/* Makes the tables of a scene of wavelets. */
static glbk_result glbk__haar_tables(glbk_context *ctx, const char *function, glbk__haar_nursery *n,
                                     glbk_sfield_scene *out)
{
    const uint64_t most = (uint64_t)1 << 28;
    glbk_result result;
    glbk__haar_lay_out(n, out->fields);
    if (n->texels > most)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "the number of texels of desc.fields",
                                  (double)n->texels, 0, (double)most);
    out->texels = (uint32_t)n->texels;
    out->entities_at = 6 * out->cube_side * out->cube_side;
    result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, out->texels + (size_t)1, &out->table);
    if (result == GLBK_OK)
        result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL,
                                    out->entities_at + (size_t)out->entity_capacity * GLBK__SFIELD_ENTITY,
                                    &out->moving);
    if (result == GLBK_OK)
        result = glbk_buffer_create(ctx, sizeof(glbk_sfield_contents), NULL, &out->contents);
    n->roots.ctx = n->nodes.ctx = ctx;
    n->roots.table = n->nodes.table = &out->table;
    if (result == GLBK_OK) result = glbk__haar_fill(n, out->fields);
    qsort(out->fields, out->field_count, sizeof *out->fields, glbk__sfield_by_pointer);
    out->key = glbk__haar_key(out);
    return result == GLBK_OK ? glbk__leave_created(ctx, glbk_sfield_haar_sky(ctx, out, NULL)) : result;
}

/* Makes a scene whose cube_side, entity_capacity and reach are set. */
static glbk_result glbk__haar_make(glbk_context *ctx, const char *function,
                                   const glbk_sfield_haar_scene_desc *d, glbk_sfield_scene *out)
{
    const glbk_haar__allocator memory = glbk_haar__memory(ctx);
    glbk_result result = GLBK_ERR_ALLOC;
    glbk__haar_nursery n;
    uint32_t *words;
    size_t i;
    memset(&n, 0, sizeof n);
    n.d = d;
    n.lists = out->lists;
    for (i = 0; i < d->field_count; i++) {
        sfield_info info;
        sfield_get_info(d->fields[i], &info);
        if (info.bytes > n.most_bytes) n.most_bytes = info.bytes;
    }
    out->fields =
        (glbk_sfield_field *)glbk_haar__alloc_array(&memory, d->field_count + 1, sizeof *out->fields);
    out->field_count = out->fields ? d->field_count : 0;
    n.tree = (glbk__haar_tree *)glbk_haar__alloc(&memory, sizeof *n.tree);
    n.bytes = (uint8_t *)glbk_haar__alloc(&memory, n.most_bytes + 1);
    words = (uint32_t *)glbk_haar__alloc(&memory, 32 * GLBK__SFIELD_STAGE);
    if (out->fields && n.tree && n.bytes && words) {
        memset(n.tree, 0, sizeof *n.tree);
        n.tree->side = out->cube_side;
        n.tree->squares = (out->cube_side * out->cube_side - 1) / 3;
        n.roots.words = words;
        n.nodes.words = words + 4 * GLBK__SFIELD_STAGE;
        n.roots.room = n.nodes.room = GLBK__SFIELD_STAGE;
        result = glbk__haar_tables(ctx, function, &n, out);
    }
    glbk_haar__free(&memory, words);
    glbk_haar__free(&memory, n.bytes);
    glbk_haar__free(&memory, n.tree);
    return result;
}

GLBK_DEF glbk_result glbk_sfield_haar_upload(glbk_context *ctx, const glbk_sfield_haar_scene_desc *d,
                                             glbk_sfield_scene *out)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    if (!d) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "desc", "is NULL");
    out->bands = 1;                             /* no rotations of coefficients are uploaded */
    out->cube_side = d->cube_side ? d->cube_side : 32;
    out->entity_capacity = d->entity_capacity;
    out->reach = d->reach;
    out->lists = ctx->compute && out->cube_side <= GLBK__HAAR_SHARED;
    result = glbk__haar_check(ctx, __func__, d, out->cube_side);
    if (result == GLBK_OK) result = glbk__haar_make(ctx, __func__, d, out);
    if (result != GLBK_OK) glbk_sfield_scene_free(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_sfield_haar_sky(glbk_context *ctx, glbk_sfield_scene *s, const float *texels)
{
    glbk_haar__allocator memory;
    uint32_t cells, face, i, c;
    uint32_t x, y;
    glbk_result result;
    float *rgba;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_scene(ctx, __func__, s);
    if (result != GLBK_OK) return result;
    if (!s->cube_side) return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "scene", "has harmonics");
    memory = glbk_haar__memory(ctx);
    cells = 6 * s->cube_side * s->cube_side;
    rgba = (float *)glbk_haar__alloc_array(&memory, cells, 16);
    if (!rgba) return GLBK_ERR_ALLOC;
    for (i = 0; i < cells; i++) {               /* from Morton order to rows */
        float direction[3], *to;
        face = i / (s->cube_side * s->cube_side);
        glbk__haar_unfold(i % (s->cube_side * s->cube_side), &x, &y);
        to = rgba + 4 * (((size_t)face * s->cube_side + y) * s->cube_side + x);
        for (c = 0; c < 3; c++) to[c] = texels ? texels[c * (size_t)cells + i] : 0;
        to[3] = sfield_cube_texel(s->cube_side, i, direction);
    }
    result = glbk__table_update(ctx, &s->moving, 0, cells, rgba);
    glbk_haar__free(&memory, rgba);
    if (result != GLBK_OK) return result;
    s->sky = texels != NULL;
    return glbk__sfield_tell(ctx, s);
}
