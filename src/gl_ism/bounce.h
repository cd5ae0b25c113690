/* ---- ism: the next bounce on the GPU ---- */

/* Checks the arguments of glbk_ism_bounces_create. */
static glbk_result glbk__ism_check_bounces(const glbk_context *ctx, const char *function,
                                           const glbk_ism_maps *m, uint32_t side)
{
    const glbk_result result = glbk__ism_check_maps(ctx, function, m);
    double texels = side;
    if (result != GLBK_OK) return result;
    if (!side || !glbk__ism_power_of_two(side) || side > m->desc.tile_side)
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, function, "side", side,
                                  "a power of two, desc.tile_side at most");
    if (!m->desc.keep_hits)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "maps", "have no desc.keep_hits");
    texels *= texels;
    if (texels < m->desc.vpl_count) texels = m->desc.vpl_count;
    if (texels <= ctx->max_side) return GLBK_OK;
    return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "side x side, or vpl_count,", texels, 1,
                              ctx->max_side);
}

GLBK_DEF glbk_result glbk_ism_bounces_create(glbk_context *ctx, const glbk_ism_maps *m, uint32_t side,
                                             glbk_ism_bounces *out)
{
    char defines[] = "ISM_PROJECTION=1";
    glbk__ism_making k;
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    result = glbk__ism_check_bounces(ctx, __func__, m, side);
    if (result != GLBK_OK) return result;
    defines[15] = (char)('0' + (int)m->desc.projection);
    out->table = m->vpls.name;
    out->side = side;
    k = glbk__ism_begin_making(ctx);
    k.defines = defines;
    glbk__ism_make_layers(&k, GLBK_FORMAT_RGBA32UI, side * side, m->desc.vpl_count, 3, &out->texels);
    glbk__ism_make_target(&k, NULL, &out->texels, 3, &out->target);
    glbk__ism_make_program(&k, "ism_bounce.frag", &out->program);
    if (k.result != GLBK_OK) glbk_ism_bounces_free(ctx, out);
    return k.result;
}

GLBK_DEF glbk_result glbk_ism_bounce(glbk_context *ctx, glbk_ism_bounces *b, const glbk_ism_maps *m)
{
    glbk_ism_frame f;
    glbk_pass pass;
    glbk_result result;
    uint32_t i;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__require_created(ctx, __func__, "bounces", b ? &b->texels.name : NULL);
    if (result == GLBK_OK) result = glbk__ism_check_maps(ctx, __func__, m);
    if (result != GLBK_OK) return result;
    if (m->vpls.name != b->table)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "maps",
                            "are not those that the bounces were made for");
    if (!m->drawn || m->outdated)           /* texels would name triangles that are gone */
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "maps", "must be drawn first: glbk_ism_draw");
    f = glbk__ism_frame_of(m);
    f.bounce_side = b->side;
    memset(&pass, 0, sizeof pass);
    pass.target = &b->target;
    result = glbk_begin(ctx, &pass, &b->program);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame, &f);
    if (result != GLBK_OK) return result;
    glbk__ism_bind_planes(ctx, m);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_below, &m->kept);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_atlas, &m->atlas);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_hits, &m->hits);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_albedos, &m->albedos);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_triangles, &m->triangle_table);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_positions, &m->positions);
    for (i = 0; i < GLBK_ISM_LEVELS; i++)
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_pull1 + i, &m->pull[i]);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF void glbk_ism_bounces_free(glbk_context *ctx, glbk_ism_bounces *b)
{
    if (!b) return;
    glbk_target_free(ctx, &b->target);
    glbk_texture_free(ctx, &b->texels);
    glbk_program_free(ctx, &b->program);
    memset(b, 0, sizeof *b);
}
