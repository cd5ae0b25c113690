/* ---- ism: near points, and all that a frame chooses ---- */

/* Draws one pass about near points: their edges and the like, their order, or their part of the table. */
static glbk_result glbk__ism_near_pass(glbk_context *ctx, glbk_ism_choice *c, const glbk_target *target,
                                       int program, const glbk_ism_choosing *b)
{
    const glbk_result result = glbk__ism_begin_choice(ctx, c, target, program, b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_near, &c->near_points.texture);
    if (program == GLBK__ISM_NEAR) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_drawn, &c->drawn.texture);
    else glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_near_facts, &c->near_sheets[0].texture);
    if (program == GLBK__ISM_NEAR_SORT) {
        ctx->gl.DrawArrays(GLBK_GL_POINTS, 0, (int32_t)c->near_point_count);
        return GLBK_OK;
    }
    if (program == GLBK__ISM_NEAR_TABLE)
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_near_order, &c->near_sheets[1].texture);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Draws the near points of the VPLs that are chosen, from the same sums, into the table behind them. */
static glbk_result glbk__ism_draw_near(glbk_context *ctx, glbk_ism_choice *c, const glbk_ism_maps *m,
                                       const glbk_texture *texels, glbk_ism_choosing b)
{
    const uint32_t vpls = b.vpl_count;
    glbk_result result;
    int k;
    b.vpl_count = c->near_point_count;
    b.first_sphere = glbk__ism_vpl_texels(m);
    b.first_near_point = b.first_sphere + glbk__ism_spheres(m);
    b.shift_bits = glbk_ism__hash_combine(b.seed, 14);
    if (m->desc.unstable) b.shift = glbk_ism__to_unit(glbk_ism__hash_combine(b.seed, 13));
    result = glbk__ism_draw_samples(ctx, c, &c->near_points.target, texels, &b);
    b.vpl_count = vpls;
    for (k = 0; k < 3 && result == GLBK_OK; k++)
        result = glbk__ism_near_pass(ctx, c, k < 2 ? &c->near_sheets[k].target : &c->table_target,
                                     GLBK__ISM_NEAR + k, &b);
    return result;
}

/* Checks the arguments of glbk_ism_choose. */
static glbk_result glbk__ism_check_choose(const glbk_context *ctx, const char *function,
                                          const glbk_ism_choice *c, const glbk_ism_maps *m,
                                          const glbk_texture *texels)
{
    glbk_result result = glbk__require_created(ctx, function, "choice", c ? &c->block.name : NULL);
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
    glbk_result result = glbk__ism_check_choose(ctx, __func__, c, m, texels);
    if (result != GLBK_OK) return result;
    if (seen || glbk__ism_by_effect(&m->desc))
        result = glbk__require_created(ctx, __func__, "seen", seen ? &seen->colors.name : NULL);
    if (result != GLBK_OK) return result;
    glbk__ism_set_choosing(c, &m->desc, seen, index, &b);
    if (b.by_effect) result = glbk__ism_draw_effects(ctx, c, texels, seen, &b);
    if (result != GLBK_OK) return result;
    result = glbk__ism_begin_choice(ctx, c, &c->importances.target, GLBK__ISM_WEIGH, &b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_texels, texels);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_effects, &c->effects.texture);
    glbk_draw_screen(ctx);
    result = glbk__ism_scan(ctx, c, &b, &c->importances.texture, c->desc.width, 0);
    if (result == GLBK_OK)
        result = glbk__ism_scan(ctx, c, &b, &c->row_sums[GLBK_ISM_SUM_LEVELS - 1].texture,
                                glbk__ism_source_rows(&c->desc), 1);
    if (result == GLBK_OK) result = glbk__ism_draw_choice(ctx, c, m, texels, seen, &b);
    if (result == GLBK_OK && c->near_point_count) result = glbk__ism_draw_near(ctx, c, m, texels, b);
    if (result != GLBK_OK) return result;
    if (m->vpl_count == m->desc.vpl_count && m->near_point_count == c->near_point_count)
        return GLBK_OK;                         /* the block says so */
    m->vpl_count = m->desc.vpl_count;
    m->near_point_count = c->near_point_count;
    return glbk__ism_write_frame(ctx, m);
}
