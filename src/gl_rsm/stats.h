/* ---- rsm: statistics of a map ---- */

/* Makes the image of statistics unless there is one: a pixel for each row of texels and each of three sums,
   as rsm_stats.frag says. */
static glbk_result glbk__rsm_stats_image(glbk_context *ctx, glbk_rsm_map *map)
{
    glbk_result result;
    if (map->stats_target.name) return GLBK_OK;
    glbk_texture_free(ctx, &map->stats);
    result = glbk__rsm_image(ctx, GLBK_FORMAT_RGBA32UI, map->side, 3 * map->face_count, 0, &map->stats);
    if (result == GLBK_OK) result = glbk__rsm_target(ctx, &map->stats, 0, 1, NULL, &map->stats_target);
    if (result != GLBK_OK) glbk_texture_free(ctx, &map->stats);
    return result;
}

/* Draws the statistics of a map. */
static glbk_result glbk__rsm_stats_draw(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map)
{
    glbk_pass pass;
    glbk_result result = glbk__rsm_program(ctx, r, GLBK__RSM_STATS);
    if (result == GLBK_OK) result = glbk__rsm_stats_image(ctx, map);
    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    pass.target = &map->stats_target;
    result = glbk_begin(ctx, &pass, &r->programs[GLBK__RSM_STATS]);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_map(ctx, map, NULL);
    glbk_draw_screen(ctx);
    return ctx->lost ? GLBK_ERR_LOST : glbk__leave_frame(ctx);
}

/* Reads the image of statistics, and adds up its rows in their order. */
static glbk_result glbk__rsm_stats_read(glbk_context *ctx, const glbk_rsm_map *map, rsm_stats *out)
{
    const uint32_t height = 3 * map->face_count;
    glbk_rsm__allocator memory = glbk_rsm__memory(ctx);
    uint32_t *words = (uint32_t *)glbk_rsm__alloc_array(&memory, (size_t)map->side * height, 16), x, y, k;
    glbk_result result;
    memset(out, 0, sizeof *out);
    if (!words) return GLBK_ERR_ALLOC;
    result = glbk_target_read(ctx, &map->stats_target, 0, 0, 0, map->side, height, words);
    for (y = 0; y < height && result == GLBK_OK; y++)
        for (x = 0; x < map->side; x++) {
            const uint32_t *from = words + 4 * ((size_t)y * map->side + x);
            float sums[3];
            memcpy(sums, from, sizeof sums);
            if (y % 3 == 0) out->lit_texels += from[0];
            for (k = 0; k < 3 && y % 3 == 1; k++) out->incident[k] += (double)sums[k];
            for (k = 0; k < 3 && y % 3 == 2; k++) out->reflected[k] += (double)sums[k];
        }
    glbk_rsm__free(&memory, words);
    return result;
}

GLBK_DEF glbk_result glbk_rsm_map_stats(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map, int count,
                                        rsm_stats *stats)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_renderer_check(ctx, __func__, r);
    if (result == GLBK_OK) result = glbk__rsm_map_check(ctx, __func__, map);
    if (result != GLBK_OK) return result;
    if (!count && !map->stats_target.name)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "count", "is 0, and nothing was counted yet");
    if (count) result = glbk__rsm_stats_draw(ctx, r, map);
    return result == GLBK_OK && stats ? glbk__rsm_stats_read(ctx, map, stats) : result;
}
