/* ---- ism: VPLs chosen on the GPU ---- */

enum { GLBK__ISM_BLOCK = 32,        /* values that one block of running sums has */
       GLBK__ISM_ROW = 256,         /* VPLs in a row of glbk_ism_choice.drawn */
       GLBK__ISM_WIDEST = 32768 };  /* values that three levels of blocks sum up */

enum { GLBK__ISM_WEIGH, GLBK__ISM_SCAN, GLBK__ISM_CHOOSE, GLBK__ISM_EDGES, GLBK__ISM_EFFECT, GLBK__ISM_EXTENT,
       GLBK__ISM_WINDOW = GLBK__ISM_EXTENT + 2, GLBK__ISM_SIGHT,
       GLBK__ISM_NEAR = GLBK__ISM_SIGHT + 2, GLBK__ISM_NEAR_SORT, GLBK__ISM_NEAR_TABLE,
       GLBK__ISM_CHOICE_PROGRAMS };

/* Returns whether effects on the picture count in the choice, and not flux alone. */
static uint32_t glbk__ism_by_effect(const ism_desc *d) { return d->importance != ISM_IMPORTANCE_FLUX; }

static uint32_t glbk__ism_blocks(uint32_t count) { return (count + GLBK__ISM_BLOCK - 1) / GLBK__ISM_BLOCK; }

/* Returns how many rows all faces of a source have. */
static uint32_t glbk__ism_source_rows(const glbk_ism_choice_desc *d) { return d->height * d->face_count; }

/* Checks a desc, whose face_count has its default, against the context's limits. */
static glbk_result glbk__ism_check_choice_desc(const glbk_context *ctx, const char *function,
                                               const glbk_ism_choice_desc *d, const ism_desc *maps)
{
    static const char fields[] =
        "maps->desc.importance\0" "a value of ism_importance\0"
        "maps->desc.view_grid_side\0" "0 or 1..16\0"
        "maps->desc.blur_radius\0" "16 at most\0"
        "maps->desc.flux_share\0" "0..1\0";
    static const glbk__ism_range ranges[] = {
        { 0, ISM_IMPORTANCE_COUNT - 1 }, { 1, 16 }, { -2147483648.0, 16 }, { 0, 1 }
    };
    const uint32_t widest = GLBK__ISM_WIDEST;
    double values[4];
    const double most = ctx->max_side < widest ? ctx->max_side : widest;
    if (!d->width || !d->height)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, d->width ? "desc.height" : "desc.width", 0,
                                  "1 or more");
    if (d->width > most)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "desc.width", d->width, 1, most);
    if ((double)d->height * d->face_count > most)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "desc.height times desc.face_count",
                                  (double)d->height * d->face_count, 1, most);
    values[0] = (double)maps->importance;
    values[1] = maps->view_grid_side;
    values[2] = maps->blur_radius;
    values[3] = (double)maps->flux_share;
    return glbk__ism_in_range(ctx, function, fields, ranges, values);
}

static void glbk__ism_make_sheet(glbk__ism_making *k, glbk_format format, uint32_t width, uint32_t height,
                                 glbk_ism_sheet *out)
{
    glbk__ism_make_canvas(k, format, width, height, NULL, &out->texture, &out->target);
}

static void glbk__ism_free_sheets(glbk_context *ctx, glbk_ism_sheet *sheets, uint32_t count)
{
    uint32_t k;
    for (k = 0; k < count; k++) {
        glbk_target_free(ctx, &sheets[k].target);
        glbk_texture_free(ctx, &sheets[k].texture);
    }
}

/* Makes programs, whose names stand one after the other, each ended by 0. */
static void glbk__ism_make_passes(glbk__ism_making *k, const char *names, glbk_program *out)
{
    for (; *names; names += strlen(names) + 1) glbk__ism_make_program(k, names, out++);
}

/* Makes one level of running sums after the other. */
static void glbk__ism_make_sums(glbk__ism_making *k, uint32_t width, uint32_t height, int columns,
                                glbk_ism_sheet *sums)
{
    uint32_t i;
    for (i = 0; i < GLBK_ISM_SUM_LEVELS; i++) {
        glbk__ism_make_sheet(k, GLBK_FORMAT_RG32UI, width, height, &sums[i]);
        if (columns) height = glbk__ism_blocks(height);
        else width = glbk__ism_blocks(width);
    }
}

/* Makes a texture of some layers, or with 0 without layers. */
static void glbk__ism_make_layers(glbk__ism_making *k, glbk_format format, uint32_t width, uint32_t height,
                                  uint32_t layers, glbk_texture *out)
{
    glbk_texture_desc d;
    memset(&d, 0, sizeof d);
    d.format = format;
    d.width = width;
    d.height = height;
    d.layers = layers;
    if (k->result == GLBK_OK) k->result = glbk_texture_create(k->ctx, &d, out);
}

/* Makes a target of `first`, which may be NULL, and then of some layers of a texture. */
static void glbk__ism_make_target(glbk__ism_making *k, const glbk_texture *first, const glbk_texture *texture,
                                  uint32_t layers, glbk_target *out)
{
    const uint32_t before = first != NULL;
    glbk_target_desc t;
    uint32_t i;
    memset(&t, 0, sizeof t);
    t.color[0] = first;
    for (i = 0; i < layers; i++) {
        t.color[before + i] = texture;
        t.layer[before + i] = i;
    }
    if (k->result == GLBK_OK) k->result = glbk__target_create(k->ctx, &t, out);
}

/* Makes pictures of four whole numbers a texel that are drawn together. */
static void glbk__ism_make_stack(glbk__ism_making *k, uint32_t width, uint32_t height, uint32_t layers,
                                 glbk_ism_sheet *out)
{
    glbk__ism_make_layers(k, GLBK_FORMAT_RGBA32UI, width, height, layers, &out->texture);
    glbk__ism_make_target(k, NULL, &out->texture, layers, &out->target);
}

/* Returns whether tiles have windows. Those for ism_bounce have none. */
static int glbk__ism_has_windows(const ism_desc *d) { return d->window_rim > 0 && !d->keep_hits; }

/* Makes what windows need. */
static void glbk__ism_make_windows(glbk__ism_making *k, const ism_desc *d, glbk_ism_choice *c)
{
    char defines[] = "ISM_PROJECTION=1";
    const glbk_texture *drawn = &c->drawn.texture;
    uint32_t i;
    if (!glbk__ism_has_windows(d)) return;
    for (i = 0; i < 2; i++) {
        glbk__ism_make_stack(k, 64, i ? 8 : 32, 2, &c->sights[i]);
        glbk__ism_make_sheet(k, GLBK_FORMAT_RGBA32UI, drawn->width, drawn->height, &c->windows[i]);
    }
    defines[15] = (char)('0' + (int)d->projection);
    k->defines = defines;
    glbk__ism_make_program(k, "ism_windows.frag", &c->programs[GLBK__ISM_WINDOW]);
    k->defines = NULL;
    glbk__ism_make_program(k, "ism_sights.frag", &c->programs[GLBK__ISM_SIGHT]);
    k->defines = "FROM=1";
    glbk__ism_make_program(k, "ism_sights.frag", &c->programs[GLBK__ISM_SIGHT + 1]);
    k->defines = NULL;
}

/* Makes what effects on the picture need. By flux alone there is one texel, which nobody reads. */
static void glbk__ism_make_effects(glbk__ism_making *k, uint32_t by_effect, glbk_ism_choice *c)
{
    const uint32_t width = by_effect ? c->desc.width : 1;
    const uint32_t rows = by_effect ? glbk__ism_source_rows(&c->desc) : 1;
    uint32_t i;
    glbk__ism_make_sheet(k, GLBK_FORMAT_R32UI, width, rows, &c->effects);
    if (!by_effect) return;
    for (i = 0; i < 3; i++)
        glbk__ism_make_stack(k, i < 2 ? GLBK__ISM_BLOCK : 1, i < 1 ? GLBK__ISM_BLOCK : 1, 2, &c->boxes[i]);
    glbk__ism_make_passes(k, "ism_effect.frag\0ism_extent.frag\0", &c->programs[GLBK__ISM_EFFECT]);
    k->defines = "FROM=1";
    glbk__ism_make_program(k, "ism_extent.frag", &c->programs[GLBK__ISM_EXTENT + 1]);
    k->defines = NULL;
}

/* Makes what near points need. There are none by 8 VPLs or fewer, since a reach goes by the eighth VPL about
   its point, and where the first layer of the table has no room for them. */
static void glbk__ism_make_near(glbk__ism_making *k, const glbk_ism_maps *m, glbk_ism_choice *c)
{
    const uint32_t vpls = m->desc.vpl_count, count = vpls * (uint32_t)m->desc.near_point_count;
    const uint32_t rows = (count + GLBK__ISM_ROW - 1) / GLBK__ISM_ROW;
    if (!count || vpls <= 8 || glbk__ism_vpl_texels(m) + glbk__ism_spheres(m) + 3 * count > 1 << 20) return;
    c->near_point_count = count;
    glbk__ism_make_stack(k, GLBK__ISM_ROW, rows, 3, &c->near_points);
    glbk__ism_make_sheet(k, GLBK_FORMAT_RGBA32UI, GLBK__ISM_ROW, rows, &c->near_sheets[0]);
    glbk__ism_make_sheet(k, GLBK_FORMAT_R32UI, GLBK__ISM_ROW, rows, &c->near_sheets[1]);
    glbk__ism_make_passes(k, "ism_near.frag\0ism_near_sort.frag\0ism_near_table.frag\0",
                          &c->programs[GLBK__ISM_NEAR]);
}

static glbk_result glbk__ism_create_choice(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_choice *c)
{
    const uint32_t width = c->desc.width, rows = glbk__ism_source_rows(&c->desc);
    glbk__ism_making k = glbk__ism_begin_making(ctx);
    glbk__ism_make_sheet(&k, GLBK_FORMAT_RG32UI, width, rows, &c->importances);
    glbk__ism_make_sums(&k, width, rows, 0, c->row_sums);
    glbk__ism_make_sums(&k, 1, rows, 1, c->column_sums);
    glbk__ism_make_effects(&k, glbk__ism_by_effect(&m->desc), c);
    glbk__ism_make_stack(&k, GLBK__ISM_ROW, (m->desc.vpl_count + GLBK__ISM_ROW - 1) / GLBK__ISM_ROW, 3,
                         &c->drawn);
    glbk__ism_make_windows(&k, &m->desc, c);
    glbk__ism_make_near(&k, m, c);
    glbk__ism_make_target(&k, NULL, &m->vpls, 1, &c->table_target);
    glbk__ism_make_block(&k, sizeof(glbk_ism_choosing), &c->block);
    glbk__ism_make_passes(&k, "ism_weigh.frag\0ism_scan.frag\0ism_choose.frag\0ism_edges.frag\0",
                          c->programs);
    c->table = m->vpls.name;
    return k.result;
}

GLBK_DEF glbk_result glbk_ism_choice_create(glbk_context *ctx, const glbk_ism_maps *m,
                                            const glbk_ism_choice_desc *desc, glbk_ism_choice *out)
{
    glbk_ism_choice_desc d;
    glbk_result result;
    result = glbk__enter_create(ctx, __func__, out, sizeof *out);
    if (result == GLBK_OK) result = glbk__ism_check_maps(ctx, __func__, m);
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
static void glbk__ism_weighing_of(const glbk_ism_choice *c, const ism_desc *maps, glbk_ism_choosing *b)
{
    const uint32_t side = c->desc.width < c->desc.height ? c->desc.width : c->desc.height;
    const double share = maps->flux_share > 0 ? (double)maps->flux_share : (double)0.1f;
    uint32_t radius = maps->blur_radius > 0 ? (uint32_t)maps->blur_radius : 0;
    if (!maps->blur_radius) radius = side < 120 ? (uint32_t)(0.05f * (float)side) : 6;
    b->grid_side = maps->view_grid_side ? maps->view_grid_side : 4;
    b->guided = maps->importance != ISM_IMPORTANCE_BRSM && maps->importance != ISM_IMPORTANCE_BRSM_MEAN;
    b->by_mean = maps->importance == ISM_IMPORTANCE_BRSM_MEAN ||
                 maps->importance == ISM_IMPORTANCE_GUIDED_MEAN;
    b->blur_radius = c->desc.scattered ? 0 : radius;
    b->flux_factor = (float)(share / (1.0 - 0.999 * share));
}

/* Sets the values of the block that all passes of a frame have in common. The random numbers are those of
   ism_choose. */
static void glbk__ism_set_choosing(const glbk_ism_choice *c, const ism_desc *maps, const glbk_gbuffer *seen,
                                   uint32_t index, glbk_ism_choosing *b)
{
    const uint32_t key = maps->unstable ? glbk_ism__hash_combine(maps->seed, index) : maps->seed;
    memset(b, 0, sizeof *b);
    if (seen) {
        b->view_width = seen->width;
        b->view_height = seen->height;
    }
    if (seen && glbk__ism_has_windows(maps)) b->windows = c->turn && !maps->unstable ? 2 : 1;
    if (seen && seen->has_clip) memcpy(b->world_to_clip, seen->world_to_clip, sizeof b->world_to_clip);
    b->width = c->desc.width;
    b->face_height = c->desc.height;
    b->vpl_count = maps->vpl_count;
    b->inter_texel = !maps->no_inter_texel && !c->desc.scattered;
    if (maps->unstable) b->shift = glbk_ism__to_unit(glbk_ism__hash_combine(key, 11));
    b->shift_bits = glbk_ism__hash_combine(key, 12);
    b->seed = key;
    b->by_effect = glbk__ism_by_effect(maps);
    b->near_point_count = c->near_point_count;
    if (b->by_effect) glbk__ism_weighing_of(c, maps, b);
}

/* Draws a pass over a whole target by a program that reads what is bound after it has begun. */
static glbk_result glbk__ism_begin_choice(glbk_context *ctx, glbk_ism_choice *c, const glbk_target *target,
                                          int program, const glbk_ism_choosing *block)
{
    glbk_pass pass;
    glbk_result result;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    if (program == GLBK__ISM_EDGES) {       /* the rows that hold VPLs */
        pass.viewport[2] = 4 * GLBK__ISM_ROW;
        pass.viewport[3] = (int32_t)c->drawn.texture.height;
    }
    result = glbk_begin(ctx, &pass, &c->programs[program]);
    if (result != GLBK_OK) return result;
    return glbk__put_block(ctx, GLBK_SLOT_glbk_ism_choosing, &c->block, block);
}

/* Sums up `count` values a row or column, which stand in `from`, level by level. */
static glbk_result glbk__ism_scan(glbk_context *ctx, glbk_ism_choice *c, glbk_ism_choosing *b,
                                  const glbk_texture *from, uint32_t count, int columns)
{
    const glbk_ism_sheet *sums = columns ? c->column_sums : c->row_sums;
    glbk_result result = GLBK_OK;
    uint32_t k;
    b->columns = columns != 0;
    b->pace = 1;
    b->value_count = count;
    b->first_column = columns ? from->width - 1 : 0;    /* where rows have their totals */
    for (k = 0; k < GLBK_ISM_SUM_LEVELS && result == GLBK_OK; k++) {
        result = glbk__ism_begin_choice(ctx, c, &sums[k].target, GLBK__ISM_SCAN, b);
        if (result != GLBK_OK) return result;
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_summed, from);
        glbk_draw_screen(ctx);
        if (k) b->value_count = glbk__ism_blocks(b->value_count);
        b->pace = GLBK__ISM_BLOCK;
        b->first_column = 0;
        from = &sums[k].texture;
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
        result = glbk__ism_begin_choice(ctx, c, &c->boxes[k].target, GLBK__ISM_EXTENT + (k > 0), b);
        if (result != GLBK_OK) return result;
        if (k) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_box, &c->boxes[k - 1].texture);
        else (void)glbk_gbuffer_bind(ctx, seen, NULL);      /* The caller has checked it. */
        glbk_draw_screen(ctx);
    }
    result = glbk__ism_begin_choice(ctx, c, &c->effects.target, GLBK__ISM_EFFECT, b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_texels, texels);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_box, &c->boxes[2].texture);
    (void)glbk_gbuffer_bind(ctx, seen, NULL);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Draws which receivers lie farthest out, and the windows that hold them. */
static glbk_result glbk__ism_draw_windows(glbk_context *ctx, glbk_ism_choice *c, const glbk_ism_maps *m,
                                          const glbk_gbuffer *seen, const glbk_ism_choosing *b)
{
    glbk_result result;
    uint32_t k;
    for (k = 0; k < 2; k++) {
        result = glbk__ism_begin_choice(ctx, c, &c->sights[k].target, GLBK__ISM_SIGHT + (int)k, b);
        if (result != GLBK_OK) return result;
        if (k) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_sights, &c->sights[0].texture);
        (void)glbk_gbuffer_bind(ctx, seen, NULL);       /* The caller has checked it. */
        glbk_draw_screen(ctx);
    }
    k = ++c->turn & 1;
    result = glbk__ism_begin_choice(ctx, c, &c->windows[k].target, GLBK__ISM_WINDOW, b);
    if (result != GLBK_OK) return result;
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_drawn, &c->drawn.texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_sights, &c->sights[1].texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_windows, &c->windows[!k].texture);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Draws VPLs, or near points, from the sums. */
static glbk_result glbk__ism_draw_samples(glbk_context *ctx, glbk_ism_choice *c, const glbk_target *target,
                                          const glbk_texture *texels, const glbk_ism_choosing *b)
{
    glbk_result result = glbk__ism_begin_choice(ctx, c, target, GLBK__ISM_CHOOSE, b);
    uint32_t k;
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_texels, texels);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_importances, &c->importances.texture);
    for (k = 0; k < GLBK_ISM_SUM_LEVELS; k++) {
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_row_sums0 + k, &c->row_sums[k].texture);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_column_sums0 + k, &c->column_sums[k].texture);
    }
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Draws the VPLs from the sums, their windows, and then the table of VPLs. */
static glbk_result glbk__ism_draw_choice(glbk_context *ctx, glbk_ism_choice *c, const glbk_ism_maps *m,
                                         const glbk_texture *texels, const glbk_gbuffer *seen,
                                         const glbk_ism_choosing *b)
{
    glbk_result result = glbk__ism_draw_samples(ctx, c, &c->drawn.target, texels, b);
    if (result != GLBK_OK) return result;
    if (b->windows) result = glbk__ism_draw_windows(ctx, c, m, seen, b);
    else c->turn = 0;
    if (result == GLBK_OK) result = glbk__ism_begin_choice(ctx, c, &c->table_target, GLBK__ISM_EDGES, b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_drawn, &c->drawn.texture);
    /* A sampler that is not read may not be without whole numbers either. */
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_windows,
                      b->windows ? &c->windows[c->turn & 1].texture : &c->importances.texture);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF void glbk_ism_choice_free(glbk_context *ctx, glbk_ism_choice *c)
{
    uint32_t k;
    if (!c) return;
    for (k = 0; k < GLBK__ISM_CHOICE_PROGRAMS; k++) glbk_program_free(ctx, &c->programs[k]);
    glbk__ism_free_sheets(ctx, c->boxes, 3);
    glbk__ism_free_sheets(ctx, &c->effects, 1);
    glbk__ism_free_sheets(ctx, &c->importances, 1);
    glbk__ism_free_sheets(ctx, c->row_sums, GLBK_ISM_SUM_LEVELS);
    glbk__ism_free_sheets(ctx, c->column_sums, GLBK_ISM_SUM_LEVELS);
    glbk__ism_free_sheets(ctx, &c->drawn, 1);
    glbk__ism_free_sheets(ctx, c->sights, 2);
    glbk__ism_free_sheets(ctx, c->windows, 2);
    glbk__ism_free_sheets(ctx, &c->near_points, 1);
    glbk__ism_free_sheets(ctx, c->near_sheets, 2);
    glbk_target_free(ctx, &c->table_target);
    glbk_buffer_free(ctx, &c->block);
    memset(c, 0, sizeof *c);
}
