/* ---- ism: drawing the maps ---- */

/* Binds the textures and the block that surfels are drawn from. */
static void glbk__ism_bind_surfels(glbk_context *ctx, const glbk_ism_maps *m)
{
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_vpls, &m->vpls);
    if (m->compute) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_surfels, &m->surfels);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_triangles, &m->triangle_table);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_positions, &m->positions);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
}

/* Runs ism_splat.comp or ism_fill.comp, with a group for each tile, or for each of the squares of that many
   texels a side that a large tile is cut into. */
static glbk_result glbk__ism_dispatch(glbk_context *ctx, const glbk_ism_maps *m, glbk_program *program,
                                      uint32_t square)
{
    uint32_t groups = m->side / (m->desc.tile_side <= 64 ? m->desc.tile_side : square);
    return glbk_dispatch(ctx, program, groups, groups, 1);
}

/* Draws the surfels of a phase, at most `most` of them in a draw. */
static glbk_result glbk__ism_draw_phase(glbk_context *ctx, glbk_ism_maps *m, uint32_t phase, uint32_t most)
{
    const uint32_t all = m->phase_surfel_count * m->desc.vpl_count;
    glbk_ism_frame f = glbk__ism_frame_of(m);
    glbk_result result = GLBK_OK;
    uint32_t first, count;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_surfels, &m->phase_surfels[phase]);
    for (first = 0; first < all && result == GLBK_OK; first += count) {
        count = all - first < most ? all - first : most;
        if (!m->quads) {
            ctx->gl.DrawArrays(GLBK_GL_POINTS, (int32_t)first, (int32_t)count);
            continue;
        }
        f.first_surfel = first;               /* since instances begin at 0 everywhere */
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame, &f);
        if (result == GLBK_OK) ctx->gl.DrawArraysInstanced(GLBK_GL_TRIANGLE_STRIP, 0, 4, (int32_t)count);
    }
    return result;
}

/* Clears the planes and draws the surfels of all phases. */
static glbk_result glbk__ism_splat(glbk_context *ctx, glbk_ism_maps *m, uint32_t surfels_per_pass)
{
    static const float empty[4] = { 0, 0, 0, 1e30f };
    glbk_pass pass;
    glbk_result result;
    uint32_t phase;
    if (m->compute) {
        glbk__ism_bind_surfels(ctx, m);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_ism_planes_out, &m->planes);
        return glbk__ism_dispatch(ctx, m, &m->splat, 64);
    }
    memset(&pass, 0, sizeof pass);
    pass.target = &m->plane_target;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_begin(ctx, &pass, &m->splat);
    if (result != GLBK_OK) return result;
    glbk_clear(ctx, &m->plane_target, 0, empty);
    glbk_clear_depth(ctx, 1);
    if (!m->triangle_count || !m->vpl_count) return GLBK_OK;
    glbk__ism_bind_surfels(ctx, m);
    for (phase = 0; phase < m->desc.lazy_frames && result == GLBK_OK; phase++)
        result = glbk__ism_draw_phase(ctx, m, phase, surfels_per_pass ? surfels_per_pass : 1u << 20);
    return result;
}

/* Binds the textures and the block that holes are found and filled from. */
static void glbk__ism_bind_planes(glbk_context *ctx, const glbk_ism_maps *m)
{
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_vpls, &m->vpls);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_planes, &m->planes);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
}

/* Draws a pass over a whole target, which reads the maps and `below`: the kept texels, or the level of pull
   below. */
static glbk_result glbk__ism_pass(glbk_context *ctx, const glbk_ism_maps *m, const glbk_target *target,
                                  glbk_program *program, const glbk_texture *below)
{
    glbk_pass pass;
    glbk_result result;
    uint32_t i;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    result = glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    if (below) {
        glbk__ism_bind_planes(ctx, m);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_below, below);
    }
    for (i = 0; target == &m->atlas_target && i < GLBK_ISM_LEVELS; i++)
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_pull1 + i, &m->pull[i]);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Makes the atlas from the surfels that were drawn: finds holes, pulls, pushes. */
static glbk_result glbk__ism_fill(glbk_context *ctx, glbk_ism_maps *m)
{
    uint32_t i, levels = glbk__ism_levels(m);
    glbk_result result;
    if (m->compute) {
        glbk__ism_bind_planes(ctx, m);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_ism_atlas_out, &m->atlas);
        return glbk__ism_dispatch(ctx, m, &m->fill, 32);
    }
    result = glbk__ism_pass(ctx, m, &m->kept_target, &m->holes, &m->planes);
    for (i = 0; i < levels && result == GLBK_OK; i++)
        result = glbk__ism_pass(ctx, m, &m->pull_target[i], &m->pull_program[i],
                                i ? &m->pull[i - 1] : &m->kept);
    return result == GLBK_OK ? glbk__ism_pass(ctx, m, &m->atlas_target, &m->push, &m->kept) : result;
}

/* Checks that the surfels of all phases were given. */
static glbk_result glbk__ism_check_phases(const glbk_context *ctx, const char *function,
                                          const glbk_ism_maps *m)
{
    char line[GLBK__LINE_ROOM];
    glbk__sink sink;
    uint32_t phase = 0;
    while (phase < m->desc.lazy_frames && (m->phases >> phase & 1)) phase++;
    if (phase == m->desc.lazy_frames) return GLBK_OK;
    glbk__begin_line(&sink, line);
    glbk__append_text(&sink, "the surfels of phase ");
    glbk__append_number(&sink, phase);
    return glbk__refuse(ctx, GLBK_ERR_ORDER, function, line,
                        "were not given since the mesh has its triangles: glbk_ism_surfels_upload");
}

GLBK_DEF glbk_result glbk_ism_draw(glbk_context *ctx, glbk_ism_maps *m, uint32_t surfels_per_pass)
{
    glbk_result result = glbk__ism_check_maps(ctx, __func__, m);
    if (result == GLBK_OK && m->triangle_count) result = glbk__ism_check_phases(ctx, __func__, m);
    if (result == GLBK_OK) result = glbk__ism_splat(ctx, m, surfels_per_pass);
    if (result == GLBK_OK) result = glbk__ism_fill(ctx, m);
    if (result != GLBK_OK) return result;
    m->drawn = 1;
    m->outdated = 0;
    return GLBK_OK;
}
