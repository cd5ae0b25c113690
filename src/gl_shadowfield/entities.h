/* ---- sfield: entities and sky, which frames change ---- */

enum { GLBK__SFIELD_MOVING = 65536 };      /* texels that go up together */

/* Returns 1 if the coefficients of an entity's fields have to be turned: the first band does not turn. */
static int glbk__sfield_turns(const float *m, uint32_t bands)
{
    return bands > 1 && (m[0] < 0 || m[5] < 0 || m[1] != 0 || m[2] != 0 || m[4] != 0 || m[6] != 0);
}

GLBK__DEF const glbk_sfield_field *glbk__sfield_find(const glbk_sfield_scene *s, const sfield_field *field)
{
    glbk_sfield_field key;
    memset(&key, 0, sizeof key);
    key.field = field;
    if (!field) return NULL;
    return (const glbk_sfield_field *)bsearch(&key, s->fields, s->field_count, sizeof key,
                                              glbk__sfield_by_pointer);
}

/* Checks entity `index` of a list. */
static glbk_result glbk__sfield_check_entity(const glbk_context *ctx, const char *function,
                                             const glbk_sfield_scene *s, const sfield_entity *e, size_t index)
{
    const glbk_sfield_field *occlusion = glbk__sfield_find(s, e->occlusion),
                            *source = glbk__sfield_find(s, e->source);
    const glbk_result input = GLBK_ERR_INPUT, mismatch = GLBK_ERR_MISMATCH;
    glbk_sfield__message name;
    float scale;
    int k;
    if (!glbk_sfield__m4_is_rigid_uniform(glbk_sfield__m4_or_identity(e->transform), &scale))
        return glbk__refuse(ctx, input, function, glbk__sfield_name(&name, "entities", index, ".transform"),
                            "is no rotation with one scale above 0 and a translation");
    for (k = 0; k < 3; k++)
        if (!(e->tint[k] >= -1e18f && e->tint[k] <= 1e18f))
            return glbk__refuse_value(ctx, input, function,
                                      glbk__sfield_name(&name, "entities", index, ".tint"),
                                      (double)e->tint[k], "-1e18..1e18");
    if (!glbk_sfield__finite(e->time))
        return glbk__refuse_value(ctx, input, function, glbk__sfield_name(&name, "entities", index, ".time"),
                                  (double)e->time, "finite");
    if (e->occlusion && (!occlusion || occlusion->source))
        return glbk__refuse(ctx, mismatch, function,
                            glbk__sfield_name(&name, "entities", index, ".occlusion"),
                            "is none of the scene's occlusion fields");
    if (!e->source || (source && source->source == 1)) return GLBK_OK;
    return glbk__refuse(ctx, mismatch, function, glbk__sfield_name(&name, "entities", index, ".source"),
                        "is none of the scene's source fields");
}

/* Writes the centre and radius of a field in the world. */
static void glbk__sfield_sphere(const float *m, const glbk_sfield_field *f, float scale, float *out)
{
    glbk_sfield__v3_store(out, glbk_sfield__m4_point(m, glbk_sfield__v3_load(f->center)));
    out[3] = scale * f->radius;
}

/* Writes the texels of an entity, which docs/gpu-layouts.md lists. rotation is the first texel of its
   rotation. */
static void glbk__sfield_entity_words(const glbk_sfield_scene *s, const sfield_entity *e, uint32_t rotation,
                                      uint32_t *words)
{
    const glbk_sfield_field *occlusion = glbk__sfield_find(s, e->occlusion),
                            *source = glbk__sfield_find(s, e->source);
    const float *m = glbk_sfield__m4_or_identity(e->transform);
    float f[4 * GLBK__SFIELD_ENTITY], scale = 1;
    uint32_t r, c;
    (void)glbk_sfield__m4_is_rigid_uniform(m, &scale);
    memset(f, 0, sizeof f);
    for (r = 0; r < 3; r++)
        for (c = 0; c < 3; c++) f[8 + 4 * r + c] = m[4 * r + c] / scale;
    if (occlusion) {
        glbk__sfield_sphere(m, occlusion, scale, f);
        f[11] = occlusion->inscribed * scale;
        f[15] = f[3];
        f[3] *= s->reach > 0 ? s->reach : occlusion->outer;
        f[3] *= f[3];
    }
    if (source) glbk__sfield_sphere(m, source, scale, f + 4);
    f[19] = e->time;
    memcpy(f + 24, e->tint, 12);
    memcpy(words, f, sizeof f);
    words[20] = occlusion ? occlusion->start : glbk__sfield_none;
    words[21] = source ? source->start : glbk__sfield_none;
    words[22] = glbk__sfield_turns(m, s->cube_side ? 2 : s->bands) ? rotation : glbk__sfield_none;
}

/* Writes the rotation of an entity, or as many texels of zeros if nothing turns. */
static void glbk__sfield_put_rotation(const glbk_sfield_scene *s, const sfield_entity *e,
                                      glbk__sfield_stage *stage)
{
    const float *m = glbk_sfield__m4_or_identity(e->transform), *block;
    uint32_t l, y, x, n;
    uint32_t *texel = NULL;
    sfield_rotation rotation;
    if (!glbk__sfield_turns(m, s->bands)) {
        for (n = glbk__sfield_rotation_texels(s->bands); n > 0; n--) (void)glbk__sfield_texel(stage);
        return;
    }
    (void)sfield_sh_rotation(s->algebra, m, &rotation);
    block = rotation.block + 1;
    for (l = 1; l < s->bands; l++)
        for (y = 0, n = 2 * l + 1; y < n; y++)
            for (x = 0; x < n; x++) {
                if (x % 4 == 0) texel = glbk__sfield_texel(stage);
                memcpy(texel + x % 4, block++, 4);
            }
}

/* Uploads a quarter turn about x, by which shaders turn BRDFs to their normals: after the sky. */
static glbk_result glbk__sfield_put_quarter(glbk_context *ctx, const glbk_sfield_scene *s)
{
    static const float turn[16] = { 1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1 };
    uint32_t words[4 * 200];                    /* 199 texels for 8 bands */
    glbk__sfield_stage stage;
    sfield_entity e;
    memset(&stage, 0, sizeof stage);
    memset(&e, 0, sizeof e);
    memcpy(e.transform, turn, sizeof turn);
    stage.ctx = ctx;
    stage.table = &s->moving;
    stage.at = s->bands * s->bands;
    stage.words = words;
    stage.room = 200;
    glbk__sfield_put_rotation(s, &e, &stage);
    glbk__sfield_flush(&stage);
    return stage.result;
}

GLBK__DEF glbk_sfield_contents glbk__sfield_contents_of(const glbk_sfield_scene *s, int sky)
{
    glbk_sfield_contents contents;
    memset(&contents, 0, sizeof contents);
    contents.entity_texel = s->entities_at;
    contents.entity_count = s->entity_count;
    contents.light_count = s->light_count;
    contents.wants_sky = sky != 0;
    contents.term_count = s->terms;
    contents.brdf_texel = s->terms;
    return contents;
}

GLBK__DEF glbk_result glbk__sfield_tell(glbk_context *ctx, const glbk_sfield_scene *s)
{
    const glbk_sfield_contents contents = glbk__sfield_contents_of(s, s->sky);
    return glbk_buffer_update(ctx, &s->contents, 0, sizeof contents, &contents);
}

/* Uploads the entities of a frame, then their rotations. */
static glbk_result glbk__sfield_move(glbk_context *ctx, const glbk_sfield_scene *s,
                                     const sfield_entity *entities, size_t count)
{
    const glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
    const uint32_t step = glbk__sfield_rotation_texels(s->bands);
    const size_t texels = count * (GLBK__SFIELD_ENTITY + step),
                 first = s->entities_at + GLBK__SFIELD_ENTITY * count;
    uint32_t words[4 * GLBK__SFIELD_ENTITY], k;
    glbk__sfield_stage stage;
    size_t i;

    memset(&stage, 0, sizeof stage);
    stage.ctx = ctx;
    stage.table = &s->moving;
    stage.at = s->entities_at;
    stage.room = texels < GLBK__SFIELD_MOVING ? texels : (size_t)GLBK__SFIELD_MOVING;
    stage.words = (uint32_t *)glbk_sfield__alloc(&memory, 16 * (stage.room + 1));
    if (!stage.words) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i++) {
        glbk__sfield_entity_words(s, &entities[i], (uint32_t)(first + i * step), words);
        for (k = 0; k < GLBK__SFIELD_ENTITY; k++) memcpy(glbk__sfield_texel(&stage), words + 4 * k, 16);
    }
    for (i = 0; i < count; i++) glbk__sfield_put_rotation(s, &entities[i], &stage);
    glbk__sfield_flush(&stage);
    glbk_sfield__free(&memory, stage.words);
    return stage.result;
}

GLBK_DEF glbk_result glbk_sfield_scene_entities(glbk_context *ctx, glbk_sfield_scene *s,
                                                const sfield_entity *entities, size_t count)
{
    glbk_result result;
    uint32_t lights = 0;
    size_t i;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_scene(ctx, __func__, s);
    if (result != GLBK_OK) return result;
    if (count && !entities) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "entities", "is NULL");
    if (count > s->entity_capacity)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, __func__, "count", (double)count, 0,
                                  s->entity_capacity);
    for (i = 0; i < count && result == GLBK_OK; i++) {
        result = glbk__sfield_check_entity(ctx, __func__, s, &entities[i], i);
        lights += entities[i].source != NULL;
    }
    if (result == GLBK_OK) result = glbk__sfield_move(ctx, s, entities, count);
    if (result != GLBK_OK) return result;
    s->entity_count = (uint32_t)count;
    s->light_count = lights;
    return glbk__sfield_tell(ctx, s);
}

GLBK_DEF glbk_result glbk_sfield_scene_sky(glbk_context *ctx, glbk_sfield_scene *s, const float *coefs)
{
    uint32_t words[4 * 64] = { 0 }, n, k, c;
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_scene(ctx, __func__, s);
    if (result != GLBK_OK) return result;
    if (s->cube_side) return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "scene", "has wavelets");
    n = s->bands * s->bands;
    for (k = 0; k < n && coefs; k++)
        for (c = 0; c < 3; c++) memcpy(&words[4 * k + c], &coefs[c * n + k], 4);
    result = glbk__table_update(ctx, &s->moving, 0, n, words);
    if (result != GLBK_OK) return result;
    s->sky = coefs != NULL;
    return glbk__sfield_tell(ctx, s);
}

GLBK_DEF void glbk_sfield_bind(glbk_context *ctx, const glbk_sfield_scene *s, const glbk_offset *offset)
{
    const glbk_offset at = glbk__offset(offset);
    if (!s) return;
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_sfield_table, &s->table);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_sfield_moving, &s->moving);
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_sfield_contents, &s->contents);
}
