/* ---- ism: drawing the maps ---- */

static void glbk__ism_bind_points(glbk_context *ctx, const glbk_ism_maps *m)
{
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_vpls, &m->vpls);
    if (m->compute) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_points, &m->points);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_triangles, &m->triangle_table);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_positions, &m->positions);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
}

/* A group of ism_splat.comp and of ism_fill.comp for each tile, or for each of the squares that it is cut into. */
static glbk_result glbk__ism_dispatch(glbk_context *ctx, const glbk_ism_maps *m, glbk_program *program, uint32_t square)
{
    uint32_t groups = m->side / (m->desc.tile_size <= 64 ? m->desc.tile_size : square);
    return glbk_dispatch(ctx, program, groups, groups, 1);
}

/* The points of a phase, as many in a draw as may be. */
static glbk_result glbk__ism_draw_phase(glbk_context *ctx, glbk_ism_maps *m, uint32_t phase)
{
    const uint32_t all = m->each * m->desc.vpl_count, most = m->desc.points_per_pass;
    glbk_ism_frame f = glbk__ism_frame_of(m);
    glbk_result result = GLBK_OK;
    uint32_t first, count;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_points, &m->phase_points[phase]);
    for (first = 0; first < all && result == GLBK_OK; first += count) {
        count = all - first < most ? all - first : most;
        if (!m->quads) {
            ctx->gl.DrawArrays(GLBK_GL_POINTS, (int32_t)first, (int32_t)count);
            continue;
        }
        f.near_points[3] = first;               /* instances begin at 0 everywhere */
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame, &f);
        if (result == GLBK_OK) ctx->gl.DrawArraysInstanced(GLBK_GL_TRIANGLE_STRIP, 0, 4, (int32_t)count);
    }
    return result;
}

/* All points, cleared before. */
static glbk_result glbk__ism_splat(glbk_context *ctx, glbk_ism_maps *m)
{
    static const float empty[4] = { 0, 0, 0, 1e30f };
    glbk_pass pass;
    glbk_result result;
    uint32_t phase;
    if (m->compute) {
        glbk__ism_bind_points(ctx, m);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_ism_surfels_out, &m->surfels);
        return glbk__ism_dispatch(ctx, m, &m->splat, 64);
    }
    memset(&pass, 0, sizeof pass);
    pass.target = &m->surfel_target;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_begin(ctx, &pass, &m->splat);
    if (result != GLBK_OK) return result;
    glbk_clear(ctx, &m->surfel_target, 0, empty);
    glbk_clear_depth(ctx, 1);
    if (!m->triangles || !m->count) return GLBK_OK;
    glbk__ism_bind_points(ctx, m);
    for (phase = 0; phase < m->desc.lazy && result == GLBK_OK; phase++) result = glbk__ism_draw_phase(ctx, m, phase);
    return result;
}

static void glbk__ism_bind_surfels(glbk_context *ctx, const glbk_ism_maps *m)
{
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_vpls, &m->vpls);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_surfels, &m->surfels);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
}

/* A pass over a whole target that reads the maps and, in the slot "below", one texture. */
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
        glbk__ism_bind_surfels(ctx, m);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_below, below);
    }
    for (i = 0; target == &m->atlas_target && i < GLBK_ISM_LEVELS; i++)
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_pull1 + i, &m->pull[i]);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* From surfels to the atlas: holes, pull, push. */
static glbk_result glbk__ism_fill(glbk_context *ctx, glbk_ism_maps *m)
{
    uint32_t i, levels = glbk__ism_levels(m);
    glbk_result result;
    if (m->compute) {
        glbk__ism_bind_surfels(ctx, m);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_ism_atlas_out, &m->atlas);
        return glbk__ism_dispatch(ctx, m, &m->fill, 32);
    }
    result = glbk__ism_pass(ctx, m, &m->kept_target, &m->holes, &m->surfels);
    for (i = 0; i < levels && result == GLBK_OK; i++)
        result = glbk__ism_pass(ctx, m, &m->pull_target[i], &m->pull_program[i], i ? &m->pull[i - 1] : &m->kept);
    return result == GLBK_OK ? glbk__ism_pass(ctx, m, &m->atlas_target, &m->push, &m->kept) : result;
}

GLBK_DEF glbk_result glbk_ism_draw(glbk_context *ctx, glbk_ism_maps *m)
{
    uint64_t all;
    glbk_result result;
    if (!ctx || !m || !m->vpls.name) return GLBK_ERR_ARGUMENT;
    all = m->desc.lazy == 64 ? ~(uint64_t)0 : ((uint64_t)1 << m->desc.lazy) - 1;
    if (m->triangles && m->phases != all) return GLBK_ERR_ARGUMENT;
    result = glbk__ism_splat(ctx, m);
    return result == GLBK_OK ? glbk__ism_fill(ctx, m) : result;
}

GLBK_DEF glbk_result glbk_ism_read(glbk_context *ctx, const glbk_ism_maps *m, float *atlas)
{
    glbk_ism__allocator memory;
    uint32_t *words, y, x;
    glbk_result result = GLBK_OK;
    if (!ctx || !m || !m->vpls.name || !atlas) return GLBK_ERR_ARGUMENT;
    memory = glbk_ism__memory(ctx);
    words = (uint32_t *)glbk_ism__alloc_array(&memory, m->side, 16);
    if (!words) return GLBK_ERR_ALLOC;
    for (y = 0; y < m->side && result == GLBK_OK; y++) {
        result = glbk_target_read(ctx, &m->atlas_target, 0, 0, y, m->side, 1, words);
        for (x = 0; x < m->side && result == GLBK_OK; x++)
            memcpy(atlas + (size_t)y * m->side + x, words + 4 * (size_t)x, 4);
    }
    glbk_ism__free(&memory, words);
    return result;
}
