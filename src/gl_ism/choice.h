/* ---- ism: VPLs chosen on the GPU ---- */

enum { GLBK__ISM_BLOCK = 32,        /* values that one block of running sums has */
       GLBK__ISM_ROW = 256,         /* VPLs in a row of glbk_ism_choice.drawn */
       GLBK__ISM_WIDEST = 32768 };  /* values that three levels of blocks sum up */

/* Returns whether effects on the picture count in the choice, and not flux alone. */
static uint32_t glbk__ism_by_effect(const ism_desc *d) { return d->importance != ISM_IMPORTANCE_FLUX; }

static uint32_t glbk__ism_blocks(uint32_t count) { return (count + GLBK__ISM_BLOCK - 1) / GLBK__ISM_BLOCK; }

/* Returns how many rows all faces of a source have. */
static uint32_t glbk__ism_source_rows(const glbk_ism_choice_desc *d) { return d->height * d->face_count; }

/* Checks a desc, whose face_count has its default, against the context's limits. */
static glbk_result glbk__ism_check_choice_desc(const glbk_context *ctx, const char *function,
                                               const glbk_ism_choice_desc *d, const ism_desc *maps)
{
    const uint32_t widest = GLBK__ISM_WIDEST;
    const double most = ctx->max_side < widest ? ctx->max_side : widest;
    if (!d->width || !d->height)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, d->width ? "desc.height" : "desc.width", 0,
                                  "1 or more");
    if (d->width > most)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "desc.width", d->width, 1, most);
    if ((double)d->height * d->face_count > most)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "desc.height times desc.face_count",
                                  (double)d->height * d->face_count, 1, most);
    if ((unsigned)maps->importance >= ISM_IMPORTANCE_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "maps->desc.importance",
                                  (double)maps->importance, "a value of ism_importance");
    if (maps->view_grid_side > 16)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "maps->desc.view_grid_side",
                                  maps->view_grid_side, "0 or 1..16");
    if (maps->blur_radius > 16)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "maps->desc.blur_radius", maps->blur_radius,
                                  "16 at most");
    if (maps->flux_share >= 0 && maps->flux_share <= 1) return GLBK_OK;
    return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "maps->desc.flux_share", (double)maps->flux_share,
                              "0..1");
}

/* Makes one level of running sums after the other. */
static glbk_result glbk__ism_create_sums(glbk_context *ctx, uint32_t width, uint32_t height, int columns,
                                         glbk_texture *textures, glbk_target *targets)
{
    glbk_result result = GLBK_OK;
    uint32_t k;
    for (k = 0; k < GLBK_ISM_SUM_LEVELS && result == GLBK_OK; k++) {
        result = glbk__canvas(ctx, GLBK_FORMAT_RG32UI, width, height, NULL, &textures[k], &targets[k]);
        if (columns) height = glbk__ism_blocks(height);
        else width = glbk__ism_blocks(width);
    }
    return result;
}

/* Makes an RGBA32UI texture of some layers, and a target of all of them. */
static glbk_result glbk__ism_create_layers(glbk_context *ctx, uint32_t width, uint32_t height,
                                           uint32_t layers, glbk_texture *texture, glbk_target *target)
{
    glbk_texture_desc d;
    glbk_target_desc t;
    glbk_result result;
    uint32_t k;
    memset(&d, 0, sizeof d);
    memset(&t, 0, sizeof t);
    d.format = GLBK_FORMAT_RGBA32UI;
    d.width = width;
    d.height = height;
    d.layers = layers;
    result = glbk_texture_create(ctx, &d, texture);
    if (result != GLBK_OK) return result;
    for (k = 0; k < layers; k++) {
        t.color[k] = texture;
        t.layer[k] = k;
    }
    return glbk__target_create(ctx, &t, target);
}

/* Makes the pictures of VPLs, and the target by which the table of maps is drawn. */
static glbk_result glbk__ism_create_drawn(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_choice *c)
{
    const uint32_t rows = (m->desc.vpl_count + GLBK__ISM_ROW - 1) / GLBK__ISM_ROW;
    glbk_target_desc t;
    const glbk_result result = glbk__ism_create_layers(ctx, GLBK__ISM_ROW, rows, 3, &c->drawn,
                                                       &c->drawn_target);
    if (result != GLBK_OK) return result;
    memset(&t, 0, sizeof t);
    t.color[0] = &m->vpls;
    return glbk__target_create(ctx, &t, &c->table_target);
}

/* Makes what effects on the picture need. By flux alone there is one texel, which nobody reads. */
static glbk_result glbk__ism_create_effects(glbk_context *ctx, uint32_t by_effect, glbk_ism_choice *c)
{
    const glbk_part *part = glbk_ism_part();
    const uint32_t width = by_effect ? c->desc.width : 1;
    const uint32_t rows = by_effect ? glbk__ism_source_rows(&c->desc) : 1;
    glbk_result result = glbk__canvas(ctx, GLBK_FORMAT_R32UI, width, rows, NULL, &c->effects,
                                      &c->effect_target);
    uint32_t k;
    if (!by_effect) return result;
    for (k = 0; k < 3 && result == GLBK_OK; k++)
        result = glbk__ism_create_layers(ctx, k < 2 ? GLBK__ISM_BLOCK : 1, k < 1 ? GLBK__ISM_BLOCK : 1, 2,
                                         &c->boxes[k], &c->box_targets[k]);
    if (result == GLBK_OK)
        result = glbk__gbuffer_program(ctx, part, "ism_extent.frag", "FROM=0", &c->extent[0]);
    if (result == GLBK_OK)
        result = glbk__gbuffer_program(ctx, part, "ism_extent.frag", "FROM=1", &c->extent[1]);
    if (result != GLBK_OK) return result;
    return glbk__gbuffer_program(ctx, part, "ism_effect.frag", NULL, &c->effect);
}

static glbk_result glbk__ism_create_choice(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_choice *c)
{
    const glbk_part *part = glbk_ism_part();
    const uint32_t width = c->desc.width, rows = glbk__ism_source_rows(&c->desc);
    glbk_result result = glbk__canvas(ctx, GLBK_FORMAT_RG32UI, width, rows, NULL, &c->importances,
                                      &c->importance_target);
    if (result == GLBK_OK)
        result = glbk__ism_create_sums(ctx, width, rows, 0, c->row_sums, c->row_targets);
    if (result == GLBK_OK)
        result = glbk__ism_create_sums(ctx, 1, rows, 1, c->column_sums, c->column_targets);
    if (result == GLBK_OK) result = glbk__ism_create_effects(ctx, glbk__ism_by_effect(&m->desc), c);
    if (result == GLBK_OK) result = glbk__ism_create_drawn(ctx, m, c);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_ism_choosing), NULL, &c->block);
    if (result == GLBK_OK) result = glbk__program_create(ctx, part, "ism_weigh.frag", NULL, &c->weigh);
    if (result == GLBK_OK) result = glbk__program_create(ctx, part, "ism_scan.frag", NULL, &c->scan);
    if (result == GLBK_OK) result = glbk__program_create(ctx, part, "ism_choose.frag", NULL, &c->choose);
    if (result == GLBK_OK) result = glbk__program_create(ctx, part, "ism_edges.frag", NULL, &c->edges);
    c->table = m->vpls.name;
    return result;
}

GLBK_DEF glbk_result glbk_ism_choice_create(glbk_context *ctx, const glbk_ism_maps *m,
                                            const glbk_ism_choice_desc *desc, glbk_ism_choice *out)
{
    glbk_ism_choice_desc d;
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    result = glbk__ism_check_maps(ctx, __func__, m);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "desc", desc);
    if (result != GLBK_OK) return result;
    d = *desc;
    if (!d.face_count) d.face_count = 1;
    result = glbk__ism_check_choice_desc(ctx, __func__, &d, &m->desc);
    if (result != GLBK_OK) return result;
    out->desc = d;
    result = glbk__ism_create_choice(ctx, m, out);
    if (result != GLBK_OK) glbk_ism_choice_free(ctx, out);
    return result;
}

/* Sets how effects on the picture are weighed, as ism_choose does. */
static void glbk__ism_weighing_of(const glbk_ism_choice *c, const ism_desc *maps, const glbk_gbuffer *seen,
                                  glbk_ism_choosing *b)
{
    const uint32_t side = c->desc.width < c->desc.height ? c->desc.width : c->desc.height;
    const double share = maps->flux_share > 0 ? (double)maps->flux_share : (double)0.1f;
    uint32_t radius = maps->blur_radius > 0 ? (uint32_t)maps->blur_radius : 0;
    if (!maps->blur_radius) radius = side < 120 ? (uint32_t)(0.05f * (float)side) : 6;
    b->view_width = seen->width;
    b->view_height = seen->height;
    b->grid_side = maps->view_grid_side ? maps->view_grid_side : 4;
    b->guided = maps->importance != ISM_IMPORTANCE_BRSM && maps->importance != ISM_IMPORTANCE_BRSM_MEAN;
    b->by_mean = maps->importance == ISM_IMPORTANCE_BRSM_MEAN ||
                 maps->importance == ISM_IMPORTANCE_GUIDED_MEAN;
    b->blur_radius = c->desc.scattered ? 0 : radius;
    b->flux_factor = (float)(share / (1.0 - 0.999 * share));
}

/* Returns the values of the block that all passes of a frame have in common. The random numbers are those of
   ism_choose. */
static glbk_ism_choosing glbk__ism_choosing_of(const glbk_ism_choice *c, const ism_desc *maps,
                                               const glbk_gbuffer *seen, uint32_t index)
{
    const uint32_t key = maps->unstable ? glbk_ism__hash_combine(maps->seed, index) : maps->seed;
    glbk_ism_choosing b;
    memset(&b, 0, sizeof b);
    if (seen && seen->has_clip) memcpy(b.world_to_clip, seen->world_to_clip, sizeof b.world_to_clip);
    b.width = c->desc.width;
    b.face_height = c->desc.height;
    b.vpl_count = maps->vpl_count;
    b.inter_texel = !maps->no_inter_texel && !c->desc.scattered;
    if (maps->unstable) b.shift = glbk_ism__to_unit(glbk_ism__hash_combine(key, 11));
    b.shift_bits = glbk_ism__hash_combine(key, 12);
    b.seed = key;
    b.by_effect = glbk__ism_by_effect(maps);
    if (b.by_effect) glbk__ism_weighing_of(c, maps, seen, &b);
    return b;
}

/* Draws a pass over a whole target by a program that reads what is bound after it has begun. */
static glbk_result glbk__ism_begin_choice(glbk_context *ctx, const glbk_ism_choice *c,
                                          const glbk_target *target, glbk_program *program,
                                          const glbk_ism_choosing *block)
{
    glbk_pass pass;
    glbk_result result;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    if (target == &c->table_target) {       /* the rows that hold VPLs */
        pass.viewport[2] = 4 * GLBK__ISM_ROW;
        pass.viewport[3] = (int32_t)c->drawn.height;
    }
    result = glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    return glbk__put_block(ctx, GLBK_SLOT_glbk_ism_choosing, &c->block, block);
}

/* Sums up `count` values a row or column, which stand in `from`, level by level. */
static glbk_result glbk__ism_scan(glbk_context *ctx, glbk_ism_choice *c, glbk_ism_choosing *b,
                                  const glbk_texture *from, uint32_t count, int columns)
{
    const glbk_texture *sums = columns ? c->column_sums : c->row_sums;
    const glbk_target *targets = columns ? c->column_targets : c->row_targets;
    glbk_result result = GLBK_OK;
    uint32_t k;
    b->columns = columns != 0;
    b->pace = 1;
    b->value_count = count;
    b->first_column = columns ? from->width - 1 : 0;    /* where rows have their totals */
    for (k = 0; k < GLBK_ISM_SUM_LEVELS && result == GLBK_OK; k++) {
        result = glbk__ism_begin_choice(ctx, c, &targets[k], &c->scan, b);
        if (result != GLBK_OK) return result;
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_summed, from);
        glbk_draw_screen(ctx);
        if (k) b->value_count = glbk__ism_blocks(b->value_count);
        b->pace = GLBK__ISM_BLOCK;
        b->first_column = 0;
        from = &sums[k];
    }
    return result;
}

/* Draws the box of the receivers, and then the effects of all texels on them. */
static glbk_result glbk__ism_draw_effects(glbk_context *ctx, glbk_ism_choice *c, const glbk_texture *texels,
                                          const glbk_gbuffer *seen, const glbk_ism_choosing *b)
{
    glbk_result result;
    uint32_t k;
    for (k = 0; k < 3; k++) {
        result = glbk__ism_begin_choice(ctx, c, &c->box_targets[k], &c->extent[k > 0], b);
        if (result != GLBK_OK) return result;
        if (k) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_box, &c->boxes[k - 1]);
        else (void)glbk_gbuffer_bind(ctx, seen, NULL);      /* The caller has checked it. */
        glbk_draw_screen(ctx);
    }
    result = glbk__ism_begin_choice(ctx, c, &c->effect_target, &c->effect, b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_texels, texels);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_box, &c->boxes[2]);
    (void)glbk_gbuffer_bind(ctx, seen, NULL);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Draws the VPLs from the sums, and then the table of VPLs. */
static glbk_result glbk__ism_draw_choice(glbk_context *ctx, glbk_ism_choice *c, const glbk_texture *texels,
                                         const glbk_ism_choosing *b)
{
    glbk_result result = glbk__ism_begin_choice(ctx, c, &c->drawn_target, &c->choose, b);
    uint32_t k;
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_texels, texels);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_importances, &c->importances);
    for (k = 0; k < GLBK_ISM_SUM_LEVELS; k++) {
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_row_sums0 + k, &c->row_sums[k]);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_column_sums0 + k, &c->column_sums[k]);
    }
    glbk_draw_screen(ctx);
    result = glbk__ism_begin_choice(ctx, c, &c->table_target, &c->edges, b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_drawn, &c->drawn);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Checks the arguments of glbk_ism_choose. */
static glbk_result glbk__ism_check_choose(const glbk_context *ctx, const char *function,
                                          const glbk_ism_choice *c, const glbk_ism_maps *m,
                                          const glbk_texture *texels)
{
    glbk_result result = glbk__require_created(ctx, function, "choice", c ? &c->drawn.name : NULL);
    if (result == GLBK_OK) result = glbk__ism_check_maps(ctx, function, m);
    if (result == GLBK_OK)
        result = glbk__require_created(ctx, function, "texels", texels ? &texels->name : NULL);
    if (result != GLBK_OK) return result;
    if (m->vpls.name != c->table)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "maps",
                            "are not those that the choice was made for");
    if (texels->format != GLBK_FORMAT_RGBA32UI)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "texels", "are not GLBK_FORMAT_RGBA32UI");
    if (texels->width != c->desc.width)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "texels->width", texels->width,
                                  "that of the choice");
    if (texels->height != c->desc.height)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "texels->height", texels->height,
                                  "that of the choice");
    if (texels->layers == 3 * c->desc.face_count) return GLBK_OK;
    return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "texels->layers", texels->layers,
                              "three for each face of the choice");
}

GLBK_DEF glbk_result glbk_ism_choose(glbk_context *ctx, glbk_ism_choice *c, glbk_ism_maps *m,
                                     const glbk_texture *texels, const glbk_gbuffer *seen, uint32_t index)
{
    glbk_ism_choosing b;
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__ism_check_choose(ctx, __func__, c, m, texels);
    if (result != GLBK_OK) return result;
    if (glbk__ism_by_effect(&m->desc))
        result = glbk__require_created(ctx, __func__, "seen", seen ? &seen->colors.name : NULL);
    if (result != GLBK_OK) return result;
    b = glbk__ism_choosing_of(c, &m->desc, seen, index);
    if (b.by_effect) result = glbk__ism_draw_effects(ctx, c, texels, seen, &b);
    if (result != GLBK_OK) return result;
    result = glbk__ism_begin_choice(ctx, c, &c->importance_target, &c->weigh, &b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_texels, texels);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_effects, &c->effects);
    glbk_draw_screen(ctx);
    result = glbk__ism_scan(ctx, c, &b, &c->importances, c->desc.width, 0);
    if (result == GLBK_OK)
        result = glbk__ism_scan(ctx, c, &b, &c->row_sums[GLBK_ISM_SUM_LEVELS - 1],
                                glbk__ism_source_rows(&c->desc), 1);
    if (result == GLBK_OK) result = glbk__ism_draw_choice(ctx, c, texels, &b);
    if (result != GLBK_OK) return result;
    if (m->vpl_count == m->desc.vpl_count && !m->near_point_count) return GLBK_OK;  /* the block says so */
    m->vpl_count = m->desc.vpl_count;
    m->near_point_count = 0;
    return glbk__ism_write_frame(ctx, m);
}

GLBK_DEF void glbk_ism_choice_free(glbk_context *ctx, glbk_ism_choice *c)
{
    uint32_t k;
    if (!c) return;
    for (k = 0; k < GLBK_ISM_SUM_LEVELS; k++) {
        glbk_target_free(ctx, &c->row_targets[k]);
        glbk_target_free(ctx, &c->column_targets[k]);
        glbk_texture_free(ctx, &c->row_sums[k]);
        glbk_texture_free(ctx, &c->column_sums[k]);
    }
    for (k = 0; k < 3; k++) {
        glbk_target_free(ctx, &c->box_targets[k]);
        glbk_texture_free(ctx, &c->boxes[k]);
    }
    glbk_target_free(ctx, &c->effect_target);
    glbk_texture_free(ctx, &c->effects);
    glbk_program_free(ctx, &c->extent[0]);
    glbk_program_free(ctx, &c->extent[1]);
    glbk_program_free(ctx, &c->effect);
    glbk_target_free(ctx, &c->importance_target);
    glbk_target_free(ctx, &c->drawn_target);
    glbk_target_free(ctx, &c->table_target);
    glbk_texture_free(ctx, &c->importances);
    glbk_texture_free(ctx, &c->drawn);
    glbk_buffer_free(ctx, &c->block);
    glbk_program_free(ctx, &c->weigh);
    glbk_program_free(ctx, &c->scan);
    glbk_program_free(ctx, &c->choose);
    glbk_program_free(ctx, &c->edges);
    memset(c, 0, sizeof *c);
}
