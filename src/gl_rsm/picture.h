/* ---- rsm: filter and picture ---- */

/* Returns the picture of bounced light, or NULL if there is none. r->bounce counts the sums, then, as 3 and
   4, the histories. */
static const glbk_texture *glbk__rsm_bounced(const glbk_rsm_renderer *r)
{
    return r->bounce < 3 ? &r->sums[r->bounce] : r->bounce < 5 ? &r->history[r->bounce - 3] : NULL;
}

/* Does all passes of the a-trous filter. */
static glbk_result glbk__rsm_smooth(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_gbuffer *gbuffer,
                                    int passes)
{
    uint32_t next;
    int pass;
    for (pass = 0; pass < passes; pass++) {
        glbk_result result;
        uint32_t step = 1u << pass, side = 16 * step;
        next = glbk__rsm_other(r->direct, r->bounce);
        r->values.step = step;
        result = r->compute
                     ? glbk__rsm_ready(ctx, r, GLBK__RSM_DO_SMOOTH)
                     : glbk__rsm_begin(ctx, r, GLBK__RSM_SMOOTH, &r->targets[next], r->width, r->height);
        if (result != GLBK_OK) return result;
        glbk__rsm_bind_all(ctx, r, gbuffer, NULL);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sum, glbk__rsm_bounced(r));
        if (r->compute) {
            glbk_bind_image(ctx, GLBK_SLOT_glbk_rsm_picture, &r->sums[next]);
            result = glbk_dispatch(ctx, &r->programs[GLBK__RSM_DO_SMOOTH], (r->width + side - 1) / side,
                                   (r->height + side - 1) / side, step * step);
            if (result != GLBK_OK) return result;
        } else {
            glbk_draw_screen(ctx);
        }
        r->bounce = next;
    }
    return GLBK_OK;
}

/* Checks that there is light which was not filtered yet. */
static glbk_result glbk__rsm_denoise_check(const glbk_context *ctx, const glbk_rsm_renderer *r,
                                           const glbk_gbuffer *gbuffer, const glbk_texture *motion)
{
    static const char function[] = "glbk_rsm_denoise";
    const glbk_result result = glbk__rsm_gbuffer_check(ctx, function, r, gbuffer);
    if (result != GLBK_OK) return result;
    if (!r->history[0].name)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "renderer", "was made without desc.denoise");
    if (!glbk__rsm_bounced(r))
        return glbk__refuse(ctx, GLBK_ERR_ORDER, function, "bounced light", "was not gathered");
    if (r->filtered)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, function, "bounced light", "was filtered already");
    if (!motion || motion->name) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "motion", "was not created");
}

GLBK_DEF glbk_result glbk_rsm_denoise(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_gbuffer *gbuffer,
                                      const gifilt_frame *frame, const glbk_texture *motion)
{
    uint32_t to;
    gifilt_frame d;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_denoise_check(ctx, r, gbuffer, motion);
    if (result == GLBK_OK) result = glbk__rsm_frame_check(ctx, frame, &d);
    if (result != GLBK_OK) return result;
    memset(&r->values, 0, sizeof r->values);
    r->values.width = r->width;
    r->values.height = r->height;
    r->values.motion = !r->remembers ? 0u : motion ? 2u : d.world_to_clip && r->has_before ? 1u : 0u;
    r->values.rows_top_first = d.rows == GIFILT_ROWS_TOP_FIRST;
    r->values.history = (float)d.history;
    r->values.normal_cosine = d.normal_cosine;
    r->values.plane_slope = d.plane_slope;
    memcpy(r->drawn.clip, r->before, sizeof r->before);
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_rsm_drawn, &r->object, &r->drawn);
    to = r->remembers == 1 ? 1 : 0;
    if (result == GLBK_OK)
        result = glbk__rsm_begin(ctx, r, GLBK__RSM_RECALL, &r->history_targets[to], r->width, r->height);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_all(ctx, r, gbuffer, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_before, &r->kept[1 - to]);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sum, glbk__rsm_bounced(r));
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_history, &r->history[1 - to]);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_motion, motion);
    glbk_draw_screen(ctx);
    r->bounce = 3 + to;
    r->remembers = 1 + to;
    r->filtered = 1;
    r->has_before = d.world_to_clip != NULL;
    if (d.world_to_clip) memcpy(r->before, d.world_to_clip, sizeof r->before);
    return glbk__rsm_smooth(ctx, r, gbuffer, d.passes);
}

GLBK_DEF void glbk_rsm_reset(glbk_rsm_renderer *r)
{
    if (r) r->remembers = 0;
}

GLBK_DEF glbk_result glbk_rsm_resolve(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_gbuffer *gbuffer,
                                      const glbk_pass *pass, const glbk_picture *picture, int direct,
                                      int bounced)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_gbuffer_check(ctx, __func__, r, gbuffer);
    if (result != GLBK_OK) return result;
    if (!pass) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "pass", "is NULL");
    memset(&r->values, 0, sizeof r->values);
    r->values.shows_direct = direct && r->direct < 3;
    r->values.shows_bounced = bounced && glbk__rsm_bounced(r);
    result = glbk__rsm_program(ctx, r, GLBK__RSM_RESOLVE);
    if (result == GLBK_OK)
        result = glbk__begin_picture(ctx, __func__, pass, picture, r->width, r->height,
                                     &r->programs[GLBK__RSM_RESOLVE]);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_rsm_frame, &r->frame, &r->values);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_all(ctx, r, gbuffer, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sum, r->direct < 3 ? &r->sums[r->direct] : NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_states, glbk__rsm_bounced(r));
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_rsm_read(glbk_context *ctx, glbk_rsm_renderer *r, int bounced, float *rgba)
{
    const glbk_target *target;
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_renderer_check(ctx, __func__, r);
    if (result != GLBK_OK) return result;
    if (!rgba) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "rgba", "is NULL");
    if (bounced)
        target = r->bounce < 3   ? &r->targets[r->bounce]
                 : r->bounce < 5 ? &r->history_targets[r->bounce - 3]
                                 : NULL;
    else target = r->direct < 3 ? &r->targets[r->direct] : NULL;
    if (target) return glbk_target_read(ctx, target, 0, 0, 0, r->width, r->height, rgba);
    return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, bounced ? "bounced light" : "direct light",
                        "is not there yet");
}
