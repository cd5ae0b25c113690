/* ---- sfield: wavelets: fields as trees ---- */

enum { GLBK__SFIELD_SQUARES = 1365 };   /* of a face of 64 x 64 texels: 1 + 4 + 16 + ... */

/* Kinds of glbk_sfield_field.source. */
enum { GLBK__SFIELD_IS_SELF = 2 };

/* A face of a sample while its tree is made. The squares of all levels are numbered one after the other, so
   that the quarters of square k are squares 4 k + 1 to 4 k + 4. */
typedef struct glbk__sfield_tree {
    uint32_t side, channels, squares;   /* squares: of all levels */
    float    scale;                     /* of the sample */
    float    coef[3][4096];             /* 0 between two faces */
    float    mean[3][4 * GLBK__SFIELD_SQUARES + 1];
    uint8_t  mark[GLBK__SFIELD_SQUARES];        /* 1: wavelets lie in the square or in its quarters */
} glbk__sfield_tree;

/* The lists of a file of wavelets. */
typedef struct glbk__sfield_lists {
    const uint8_t *offsets, *scales, *entries;
    uint32_t       samples, words;      /* words of an entry */
} glbk__sfield_lists;

static glbk__sfield_lists glbk__sfield_lists_of(const uint8_t *bytes, const glbk__sfield_view *v)
{
    glbk__sfield_lists l;
    l.offsets = bytes + v->scales;
    l.samples = v->samples;
    l.scales = l.offsets + 4 * ((size_t)v->samples + 1);
    l.entries = l.scales + 4 * (size_t)v->samples;
    l.words = v->stride;
    return l;
}

/* Returns the bytes of entry i. glbk__sfield_face moves *end past those entries of a sample whose number is
   below `texels`: there the entries of the next face begin. */
static const uint8_t *glbk__sfield_entry(const glbk__sfield_lists *l, size_t i)
{
    return l->entries + 4 * i * l->words;
}

static void glbk__sfield_face(const glbk__sfield_lists *l, uint32_t sample, uint32_t texels, size_t *end)
{
    const size_t last = glbk__sfield_word(l->offsets + 4 * ((size_t)sample + 1));
    while (*end < last && glbk__sfield_word(glbk__sfield_entry(l, *end)) >> 16 < texels) (*end)++;
}

/* Marks the squares of a face's entries and all above these. Returns how many nodes the tree has but the
   root. */
static uint32_t glbk__sfield_mark(glbk__sfield_tree *t, const glbk__sfield_lists *l, size_t from, size_t end)
{
    const uint32_t in_face = t->side * t->side - 1;
    uint32_t nodes = 0;
    memset(t->mark, 0, t->squares);
    for (; from < end; from++) {
        uint32_t k = glbk__sfield_word(glbk__sfield_entry(l, from)) >> 16 & in_face;
        if (!k) continue;
        for (k = (k - 1) / 3; k && !t->mark[k]; k = (k - 1) / 4) {
            t->mark[k] = 1;
            nodes++;
        }
    }
    return nodes;
}

/* Writes the coefficients of a face's entries, or zeros in their places. */
static void glbk__sfield_scatter(glbk__sfield_tree *t, const glbk__sfield_lists *l, size_t from, size_t end,
                                 float scale)
{
    const uint32_t in_face = t->side * t->side - 1;
    for (; from < end; from++) {
        const uint8_t *e = glbk__sfield_entry(l, from);
        const uint32_t first = glbk__sfield_word(e), at = first >> 16 & in_face;
        uint32_t value[3], c;
        value[0] = first;
        value[1] = l->words > 1 ? glbk__sfield_word(e + 4) >> 16 : 0;
        value[2] = l->words > 1 ? glbk__sfield_word(e + 4) : 0;
        for (c = 0; c < t->channels; c++)
            t->coef[c][at] = scale * ((float)(int32_t)((value[c] & 0xffffu) ^ 0x8000u) - 32768.0f);
    }
}

/* Computes the means of the quarters of square k, which has so many texels a side. Returns the greatest. */
static float glbk__sfield_quarter(glbk__sfield_tree *t, uint32_t k, float side)
{
    float most = 0, scale = 1 / side;
    uint32_t c, q;
    for (c = 0; c < t->channels; c++)
        for (q = 0; q < 4; q++) {
            const float *w = t->coef[c] + 1 + 3 * k, x = q & 1 ? -scale : scale, y = q & 2 ? -scale : scale;
            const float z = q == 0 || q == 3 ? scale : -scale;
            const float mean = t->mean[c][k] + x * w[0] + y * w[1] + z * w[2];
            t->mean[c][4 * k + 1 + q] = mean;
            most = fabsf(mean) > most ? fabsf(mean) : most;
        }
    return most;
}

/* Writes the node of square k, whose quarters' first node is texel `below` of the table. Returns how many
   quarters have a node. */
static uint32_t glbk__sfield_node(glbk__sfield_tree *t, uint32_t k, float side, uint32_t below,
                                  glbk__sfield_stage *s)
{
    const float most = glbk__sfield_quarter(t, k, side), scale = most / 32767;
    uint32_t *texel = glbk__sfield_texel(s), *second = texel;
    uint32_t q, c, nodes = 0, mask = 0;
    for (q = 0; q < 4; q++) {
        const uint32_t quarter = 4 * k + 1 + q;
        if (quarter >= t->squares || !t->mark[quarter]) continue;
        mask |= 1u << q;
        nodes++;
    }
    texel[2] = mask << 28 | (mask ? below : 0);     /* past the last of 2^28 texels it has 29 bits */
    memcpy(texel + 3, &scale, 4);
    for (c = 0; c < t->channels; c++) {
        if (c == 1) second = glbk__sfield_texel(s);
        for (q = 0; q < 4; q++) {
            const float x = scale > 0 ? t->mean[c][4 * k + 1 + q] / scale : 0;
            const uint32_t bits = (uint32_t)(int32_t)(x + (x < 0 ? -0.5f : 0.5f)) & 0xffffu;
            second[(c > 1 ? 2 : 0) + q / 2] |= bits << q % 2 * 16;
        }
    }
    return nodes;
}

/* Writes the tree of a face: its root to one stage, all other nodes to the other, level by level. */
static void glbk__sfield_plant(glbk__sfield_tree *t, glbk__sfield_stage *roots, glbk__sfield_stage *nodes)
{
    const uint32_t step = t->channels > 1 ? 2 : 1;
    uint32_t k, level_end = 1, below = (uint32_t)(nodes->at + nodes->count), c;
    float side = (float)t->side;
    for (c = 0; c < t->channels; c++) t->mean[c][0] = t->coef[c][0] / side;
    for (k = 0; k < t->squares; k++) {
        if (k == level_end) {
            level_end = 4 * level_end + 1;
            side *= 0.5f;
        }
        if (!k || t->mark[k]) below += step * glbk__sfield_node(t, k, side, below, k ? nodes : roots);
    }
}

/* Counts the nodes of a file but the roots or, with stages, writes all trees. */
static uint64_t glbk__sfield_trees(glbk__sfield_tree *t, const glbk__sfield_lists *l,
                                   glbk__sfield_stage *roots, glbk__sfield_stage *nodes)
{
    const uint32_t texels = t->side * t->side;
    uint64_t count = 0;
    uint32_t sample, face;
    for (sample = 0; sample < l->samples; sample++) {
        size_t from = glbk__sfield_word(l->offsets + 4 * (size_t)sample), end = from;
        for (face = 0; face < 6; face++, from = end) {
            glbk__sfield_face(l, sample, (face + 1) * texels, &end);
            count += glbk__sfield_mark(t, l, from, end);
            if (!roots) continue;
            glbk__sfield_scatter(t, l, from, end, glbk__sfield_float(l->scales + 4 * (size_t)sample));
            glbk__sfield_plant(t, roots, nodes);
            glbk__sfield_scatter(t, l, from, end, 0);
        }
    }
    return count;
}

/* Writes the first texels of a field, up to its roots. Those of harmonics have the same places. */
static void glbk__sfield_haar_head(glbk__sfield_stage *s, const glbk__sfield_view *v)
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
    texel[0] = glbk__sfield_word(v->bytes + 92);
    for (i = 0; i < v->shells; i++) {
        pair[0] = glbk__sfield_float(v->bytes + 4 * (GLBK__SFIELD_HEADER + (size_t)i));
        pair[0] *= pair[0];
        pair[1] = glbk__sfield_measure(pair[0], v->kind == 1, v->spacing == SFIELD_SPACING_UNIFORM);
        memcpy(glbk__sfield_texel(s), pair, sizeof pair);
    }
}

/* Returns why a scene of wavelets cannot have a field, or NULL if it can. */
static const char *glbk__sfield_haar_refuse(const sfield_info *info, uint32_t side)
{
    if (info->basis != SFIELD_BASIS_HAAR) return "is one of harmonics, which glbk_sfield_scene_create takes";
    if (info->cube_side != side) return "has another cube_side than desc.cube_side";
    return info->shard_end ? "is a shard: sfield_merge first" : NULL;
}

static glbk_result glbk__sfield_haar_check(const glbk_context *ctx, const char *function,
                                           const glbk_sfield_haar_scene_desc *d, uint32_t side)
{
    glbk_sfield__message name;
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
            why = glbk__sfield_haar_refuse(&info, side);
        }
        if (why)
            return glbk__refuse(ctx, d->fields[i] ? GLBK_ERR_MISMATCH : GLBK_ERR_DESC, function,
                                glbk__sfield_name(&name, "desc.fields", i, ""), why);
    }
    return GLBK_OK;
}

/* What making a scene of wavelets needs for a while. */
typedef struct glbk__sfield_nursery {
    const glbk_sfield_haar_scene_desc *d;
    glbk__sfield_tree *tree;
    uint8_t  *bytes;                    /* of the file of a field */
    size_t    most_bytes;
    uint64_t  texels;                   /* so far */
    glbk__sfield_stage roots, nodes;
} glbk__sfield_nursery;

/* Reads field i, and says of the scene's entry where it begins. Returns the lists. */
static glbk__sfield_lists glbk__sfield_haar_open(glbk__sfield_nursery *n, size_t i, glbk__sfield_view *v)
{
    (void)sfield_write(n->d->fields[i], n->bytes, n->most_bytes);
    glbk__sfield_read(n->bytes, v);
    v->scales = 4 * (GLBK__SFIELD_HEADER + (size_t)v->shells);
    n->tree->channels = v->channels;
    return glbk__sfield_lists_of(n->bytes, v);
}

/* Finds where all fields begin, and where they end. */
static void glbk__sfield_haar_lay_out(glbk__sfield_nursery *n, glbk_sfield_field *fields)
{
    size_t i;
    for (i = 0; i < n->d->field_count && n->texels <= (uint64_t)1 << 28; i++) {
        glbk__sfield_view v;
        const glbk__sfield_lists l = glbk__sfield_haar_open(n, i, &v);
        const uint64_t nodes = 6 * (uint64_t)v.samples + glbk__sfield_trees(n->tree, &l, NULL, NULL);
        sfield_info info;
        sfield_get_info(n->d->fields[i], &info);
        fields[i].field = n->d->fields[i];
        fields[i].start = (uint32_t)n->texels;
        fields[i].source = info.kind == SFIELD_KIND_SOURCE      ? 1
                           : info.kind == SFIELD_KIND_OCCLUSION ? 0
                                                                : GLBK__SFIELD_IS_SELF;
        memcpy(fields[i].center, info.center, sizeof info.center);
        fields[i].radius = info.radius;
        fields[i].inscribed = info.inscribed;
        fields[i].outer = info.outer;
        n->texels += 3 + v.shells + nodes * (v.channels > 1 ? 2 : 1);
    }
}

/* Uploads all fields. */
static glbk_result glbk__sfield_haar_fill(glbk__sfield_nursery *n, const glbk_sfield_field *fields)
{
    size_t i;
    for (i = 0; i < n->d->field_count && n->roots.result == GLBK_OK; i++) {
        glbk__sfield_view v;
        const glbk__sfield_lists l = glbk__sfield_haar_open(n, i, &v);
        n->roots.at = fields[i].start;
        n->nodes.at = fields[i].start + 3 + v.shells + 6 * (size_t)v.samples * (v.channels > 1 ? 2 : 1);
        glbk__sfield_haar_head(&n->roots, &v);
        (void)glbk__sfield_trees(n->tree, &l, &n->roots, &n->nodes);
        glbk__sfield_flush(&n->roots);
        glbk__sfield_flush(&n->nodes);
        if (n->roots.result == GLBK_OK) n->roots.result = n->nodes.result;
    }
    return n->roots.result;
}

/* Returns a number for where a scene's fields begin and end in its table, never 0. Scenes of one number have
   the self-visibilities of each other: a field made anew at an old one's address has another size. */
static uint64_t glbk__sfield_haar_key(const glbk_sfield_scene *s)
{
    uint64_t key = s->texels;
    size_t i;
    for (i = 0; i < s->field_count; i++)
        key = (key ^ ((uint64_t)(uintptr_t)s->fields[i].field << 8 ^ s->fields[i].start)) * 1099511628211u;
    return key | 1;
}

/* Makes the tables of a scene of wavelets. */
static glbk_result glbk__sfield_haar_tables(glbk_context *ctx, const char *function, glbk__sfield_nursery *n,
                                            glbk_sfield_scene *out)
{
    const uint64_t most = (uint64_t)1 << 28;
    glbk_result result;
    glbk__sfield_haar_lay_out(n, out->fields);
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
    if (result == GLBK_OK) result = glbk__sfield_haar_fill(n, out->fields);
    qsort(out->fields, out->field_count, sizeof *out->fields, glbk__sfield_by_pointer);
    out->key = glbk__sfield_haar_key(out);
    return result == GLBK_OK ? glbk__leave_created(ctx, glbk_sfield_haar_sky(ctx, out, NULL)) : result;
}

/* Makes a scene whose cube_side, entity_capacity and reach are set. */
static glbk_result glbk__sfield_haar_make(glbk_context *ctx, const char *function,
                                          const glbk_sfield_haar_scene_desc *d, glbk_sfield_scene *out)
{
    const glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
    glbk_result result = GLBK_ERR_ALLOC;
    glbk__sfield_nursery n;
    uint32_t *words;
    size_t i;
    memset(&n, 0, sizeof n);
    n.d = d;
    for (i = 0; i < d->field_count; i++) {
        sfield_info info;
        sfield_get_info(d->fields[i], &info);
        if (info.bytes > n.most_bytes) n.most_bytes = info.bytes;
    }
    out->fields =
        (glbk_sfield_field *)glbk_sfield__alloc_array(&memory, d->field_count + 1, sizeof *out->fields);
    out->field_count = out->fields ? d->field_count : 0;
    n.tree = (glbk__sfield_tree *)glbk_sfield__alloc(&memory, sizeof *n.tree);
    n.bytes = (uint8_t *)glbk_sfield__alloc(&memory, n.most_bytes + 1);
    words = (uint32_t *)glbk_sfield__alloc(&memory, 32 * GLBK__SFIELD_STAGE);
    if (out->fields && n.tree && n.bytes && words) {
        memset(n.tree, 0, sizeof *n.tree);
        n.tree->side = out->cube_side;
        n.tree->squares = (out->cube_side * out->cube_side - 1) / 3;
        n.roots.words = words;
        n.nodes.words = words + 4 * GLBK__SFIELD_STAGE;
        n.roots.room = n.nodes.room = GLBK__SFIELD_STAGE;
        result = glbk__sfield_haar_tables(ctx, function, &n, out);
    }
    glbk_sfield__free(&memory, words);
    glbk_sfield__free(&memory, n.bytes);
    glbk_sfield__free(&memory, n.tree);
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
    result = glbk__sfield_haar_check(ctx, __func__, d, out->cube_side);
    if (result == GLBK_OK) result = glbk__sfield_haar_make(ctx, __func__, d, out);
    if (result != GLBK_OK) glbk_sfield_scene_free(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_sfield_haar_sky(glbk_context *ctx, glbk_sfield_scene *s, const float *texels)
{
    glbk_sfield__allocator memory;
    uint32_t cells, face, i, c;
    uint32_t x, y, bit;
    glbk_result result;
    float *rgba;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_scene(ctx, __func__, s);
    if (result != GLBK_OK) return result;
    if (!s->cube_side) return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "scene", "has harmonics");
    memory = glbk_sfield__memory(ctx);
    cells = 6 * s->cube_side * s->cube_side;
    rgba = (float *)glbk_sfield__alloc_array(&memory, cells, 16);
    if (!rgba) return GLBK_ERR_ALLOC;
    for (i = 0; i < cells; i++) {               /* from Morton order to rows */
        float direction[3], *to;
        face = i / (s->cube_side * s->cube_side);
        for (x = y = bit = 0; 1u << bit < s->cube_side; bit++) {
            x |= (i >> 2 * bit & 1) << bit;
            y |= (i >> (2 * bit + 1) & 1) << bit;
        }
        to = rgba + 4 * (((size_t)face * s->cube_side + y) * s->cube_side + x);
        for (c = 0; c < 3; c++) to[c] = texels ? texels[c * (size_t)cells + i] : 0;
        to[3] = sfield_cube_texel(s->cube_side, i, direction);
    }
    result = glbk__table_update(ctx, &s->moving, 0, cells, rgba);
    glbk_sfield__free(&memory, rgba);
    if (result != GLBK_OK) return result;
    s->sky = texels != NULL;
    return glbk__sfield_tell(ctx, s);
}
