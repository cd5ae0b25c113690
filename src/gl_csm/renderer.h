/* ---- csm: the renderer: samples of lights, summed over frames ---- */

/* Returns the kind of a light with the default resolved. */
static uint32_t glbk__csm_shape_of(const glbk_csm_use *u)
{
    return u->kind == LSAMP_LIGHT_DEFAULT ? (uint32_t)LSAMP_LIGHT_ENVIRONMENT : (uint32_t)u->kind;
}

/* Finds or compiles the program for a combination of shape, ask, filter and defines of maps. */
static glbk_result glbk__csm_shade_program(glbk_context *ctx, const char *function, glbk_csm_renderer *r,
                                           const glbk_csm_use *use, uint32_t filter, glbk_program **out)
{
    char defines[] = "CSM_ASK=0 CSM_FILTER=0 COHSM_LOBES=1 CSM_SHAPE=10 CSM_PATTERNS COHSM_OWN_LIGHT";
    const char *texts[2];
    uint32_t shape = glbk__csm_shape_of(use), ask = (uint32_t)use->ask;
    texts[0] = defines;
    texts[1] = r->light;
    defines[8] = (char)('0' + ask);
    defines[21] = (char)('0' + filter);
    defines[35] = (char)('0' + r->lobe_count);
    defines[48] = (char)('0' + shape % 10);
    if (shape < 10) {
        defines[47] = defines[48];
        defines[48] = ' ';
    }
    if (!r->patterns) memset(defines + 50, ' ', 12);
    if (!r->light) defines[62] = 0;
    return glbk__csm_program(ctx, function, &r->shade, shape * 16 + ask * 4 + filter,
                             r->compute ? "csm_shade.comp" : "csm_shade.frag", texts, use->maps, out);
}

GLBK_DEF glbk_result glbk_csm_renderer_create(glbk_context *ctx, const glbk_csm_renderer_desc *d,
                                              glbk_csm_renderer *out)
{
    glbk_result result;

    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "desc", d);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "desc.width", d->width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "desc.height", d->height);
    if (result != GLBK_OK) return result;
    if (d->lobe_count > LSAMP_MAX_LOBES)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, __func__, "desc.lobe_count", d->lobe_count, 0,
                                 LSAMP_MAX_LOBES);
    out->width = d->width;
    out->height = d->height;
    out->compute = ctx->compute;
    out->lobe_count = d->lobe_count ? d->lobe_count : 1;
    out->patterns = d->patterns != 0;
    out->light = d->light;
    result = glbk__gbuffer_program(ctx, glbk_csm_part(), "csm_resolve.frag", NULL, &out->resolve);
    if (result == GLBK_OK)
        result = glbk__sums_create(ctx, out->compute, d->width, d->height, out->sums, out->targets);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_csm_frame), NULL, &out->frame);
    if (result != GLBK_OK) glbk_csm_renderer_free(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_csm_renderer_resize(glbk_context *ctx, glbk_csm_renderer *r, uint32_t width,
                                              uint32_t height)
{
    glbk_result result =
        glbk__require_created(ctx, __func__, "renderer", r ? &r->targets[0].name : NULL);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "width", width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "height", height);
    if (result != GLBK_OK) return result;
    glbk__sums_free(ctx, r->sums, r->targets);
    glbk_csm_reset(r);
    r->width = width;
    r->height = height;
    result = glbk__sums_create(ctx, r->compute, width, height, r->sums, r->targets);
    if (result != GLBK_OK) glbk_csm_renderer_free(ctx, r);
    return result;
}

GLBK_DEF void glbk_csm_renderer_free(glbk_context *ctx, glbk_csm_renderer *r)
{
    if (!r) return;
    glbk__csm_programs_free(ctx, &r->shade);
    glbk_program_free(ctx, &r->resolve);
    glbk__sums_free(ctx, r->sums, r->targets);
    glbk_buffer_free(ctx, &r->frame);
    memset(r, 0, sizeof *r);
}

/* Checks light i of a frame. */
static glbk_result glbk__csm_check_use(const glbk_context *ctx, const char *function,
                                       const glbk_csm_renderer *r, const glbk_csm_frame_desc *d, size_t i)
{
    const glbk_csm_use *u = &d->uses[i];
    const glbk__csm_logger log = glbk__csm_logger_make(ctx, function, "desc.uses", i);
    if (!u->maps || !u->maps->blocks.name) {
        (void)glbk__csm_refuse(&log, ".maps", u->maps ? "was not created" : "is NULL");
        return GLBK_ERR_DESC;
    }
    if (!glbk__csm_in(&log, ".ask", (double)u->ask, 0, COHSM_LIGHT_COUNT - 1, "a COHSM_LIGHT_...") ||
        !glbk__csm_kind_valid(&log, u->kind, r->light != NULL) ||
        !glbk__csm_in(&log, ".sample_count", u->sample_count, 1, 65536, "1..65536") ||
        !glbk__csm_in(&log, ".start", u->start, 2.0 * d->lights->lobe_count, d->lights->patterns_at - 1.0,
                      "one that glbk_csm_lights_create wrote"))
        return GLBK_ERR_DESC;
    if (r->patterns && !glbk__csm_in(&log, ".sample_count", u->sample_count, d->lights->pattern_length,
                                     d->lights->pattern_length, "the length of the patterns"))
        return GLBK_ERR_MISMATCH;
    return GLBK_OK;
}

/* Checks the desc of a frame. */
static glbk_result glbk__csm_check_frame(const glbk_context *ctx, const char *function,
                                         const glbk_csm_renderer *r, const glbk_csm_frame_desc *d)
{
    const glbk__csm_logger log = glbk__csm_logger_make(ctx, function, "desc", GLBK__NO_INDEX);
    glbk__csm_logger planes = glbk__csm_logger_make(ctx, function, "desc.planes", 0);
    glbk_result result = glbk__require_created(ctx, function, "renderer", r ? &r->targets[0].name : NULL);
    uint32_t i;

    if (result == GLBK_OK) result = glbk__require(ctx, function, "desc", d);
    if (result != GLBK_OK) return result;
    if (!d->lights || !d->lights->texels.name) {
        (void)glbk__csm_refuse(&log, ".lights", d->lights ? "was not created" : "is NULL");
        return GLBK_ERR_DESC;
    }
    if (d->lights->own && !r->light)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "desc.lights",
                            "were made with own, but the renderer without light, the GLSL for them");
    if ((d->use_count && !d->uses && !glbk__csm_refuse(&log, ".uses", "is NULL")) ||
        !glbk__csm_in(&log, ".plane_count", d->plane_count, 0, GLBK_CSM_MAX_PLANES, "0..8") ||
        !glbk__csm_in(&log, ".sampling", (double)d->sampling, 0, LSAMP_SAMPLING_COUNT - 1,
                      "a LSAMP_SAMPLING_...") ||
        !glbk__csm_in(&log, ".filter", (double)d->filter, 0, COHSM_FILTER_COUNT - 1, "a COHSM_FILTER_...") ||
        !glbk__csm_in(&log, ".bias", (double)d->bias, -1e39, 1e39, "finite") ||
        !glbk__csm_in(&log, ".offset", (double)d->offset, 0, 1e39, "0 or more, and finite"))
        return GLBK_ERR_DESC;
    for (i = 0; i < d->plane_count; i++) {
        planes.index = i;
        if (!glbk__csm_unit(&planes, "'s normal: its length", d->planes[i]) ||
            !glbk__csm_in(&planes, "[3]", (double)d->planes[i][3], -1e39, 1e39, "finite"))
            return GLBK_ERR_DESC;
    }
    if (r->frame_count == UINT32_MAX)
        return glbk__refuse(ctx, GLBK_ERR_LIMIT, function, "renderer", "has 2^32 - 1 frames, which are all");
    for (i = 0; i < d->use_count && result == GLBK_OK; i++)
        result = glbk__csm_check_use(ctx, function, r, d, i);
    return result;
}

/* Adds samples frame->first .. end - 1 of one light to the sum. */
static glbk_result glbk__csm_shade_pass(glbk_context *ctx, glbk_csm_renderer *r, const glbk_gbuffer *gbuffer,
                                        const glbk_csm_use *use, const glbk_csm_lights *lights,
                                        const glbk_csm_frame *frame, glbk_program *program)
{
    glbk_pass pass;
    glbk_result result = glbk__put_block(ctx, GLBK_SLOT_glbk_csm_frame, &r->frame, frame);

    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    pass.target = &r->targets[!r->now];
    if (!r->compute) result = glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    glbk_csm_bind(ctx, use->maps, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_lights, &lights->texels);
    result = glbk_gbuffer_bind(ctx, gbuffer, NULL);
    if (result != GLBK_OK) return result;
    r->passes = 1;
    if (r->compute) {
        glbk_bind_image(ctx, GLBK_SLOT_glbk_csm_total, &r->sums[0]);
        return glbk_dispatch(ctx, program, (r->width + 7) / 8, (r->height + 7) / 8, 1);
    }
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_sum, &r->sums[r->now]);
    glbk_draw_screen(ctx);
    r->now = !r->now;
    return GLBK_OK;
}

/* Checks a frame, and compiles what it needs. */
static glbk_result glbk__csm_prepare(glbk_context *ctx, const char *function, glbk_csm_renderer *r,
                                     const glbk_csm_frame_desc *d)
{
    glbk_result result = glbk__csm_check_frame(ctx, function, r, d);
    glbk_program *program;
    uint32_t i;

    if (result != GLBK_OK) return result;
    r->shade.frame++;
    for (i = 0; i < d->use_count && result == GLBK_OK; i++)
        result = glbk__csm_shade_program(ctx, function, r, &d->uses[i], (uint32_t)d->filter, &program);
    return result;
}

GLBK_DEF glbk_result glbk_csm_prepare(glbk_context *ctx, glbk_csm_renderer *r, const glbk_csm_frame_desc *d)
{
    return glbk__csm_prepare(ctx, __func__, r, d);
}

/* Checks that renderer and G-buffer were created, and that they have one size. */
static glbk_result glbk__csm_check_gbuffer(const glbk_context *ctx, const char *function,
                                           const glbk_csm_renderer *r, const glbk_gbuffer *g)
{
    const glbk_result result =
        glbk__require_created(ctx, function, "renderer", r ? &r->targets[0].name : NULL);
    return result == GLBK_OK ? glbk__require_gbuffer(ctx, function, g, r->width, r->height) : result;
}

GLBK_DEF glbk_result glbk_csm_render(glbk_context *ctx, glbk_csm_renderer *r, const glbk_gbuffer *gbuffer,
                                     const glbk_csm_frame_desc *d)
{
    glbk_csm_frame frame;
    glbk_program *program;
    glbk_result result = glbk__csm_check_gbuffer(ctx, __func__, r, gbuffer);
    uint32_t i, from, step;

    if (result == GLBK_OK) result = glbk__csm_prepare(ctx, __func__, r, d);
    if (result != GLBK_OK) return result;
    memset(&frame, 0, sizeof frame);
    step = d->samples_per_pass ? d->samples_per_pass : 64;
    memcpy(frame.eye, d->eye, sizeof d->eye);
    memcpy(frame.planes, d->planes, sizeof d->planes);
    frame.bias = glbk__csm_bias(d->bias);
    frame.offset = d->offset;
    frame.pattern_texel = d->lights->patterns_at;
    frame.plane_count = d->plane_count;
    frame.width = r->width;
    frame.height = r->height;
    frame.frame = d->frame;
    frame.sampling = (uint32_t)d->sampling;
    for (i = 0; i < d->use_count && result == GLBK_OK; i++) {
        const glbk_csm_use *u = &d->uses[i];
        result = glbk__csm_shade_program(ctx, __func__, r, u, (uint32_t)d->filter, &program);
        frame.light_texel = u->start;
        memcpy(frame.own, u->own, sizeof u->own);
        frame.sample_count = u->sample_count;
        frame.seed = u->seed;
        frame.roulette_seed = u->seed * 0x9e3779b9u + d->frame * 0x85ebca6bu;
        for (from = 0; from < u->sample_count && result == GLBK_OK; from = frame.end) {
            frame.first = from;
            frame.end = u->sample_count - from < step ? u->sample_count : from + step;
            frame.adds = r->passes != 0;
            result = glbk__csm_shade_pass(ctx, r, gbuffer, u, d->lights, &frame, program);
        }
    }
    if (result == GLBK_OK) r->frame_count++;
    return result;
}

GLBK_DEF void glbk_csm_reset(glbk_csm_renderer *r)
{
    if (r) r->frame_count = r->passes = 0;
}

GLBK_DEF glbk_result glbk_csm_resolve(glbk_context *ctx, glbk_csm_renderer *r, const glbk_gbuffer *gbuffer,
                                      const glbk_pass *pass, const glbk_picture *picture)
{
    const int asks = picture && (picture->keep_empty || picture->world_to_clip);
    glbk_csm_frame frame;
    glbk_result result = glbk__require_created(ctx, __func__, "renderer", r ? &r->resolve.name : NULL);
    uint32_t i;

    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "pass", pass);
    if (result == GLBK_OK && asks && !gbuffer)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "gbuffer",
                            "is NULL, but picture asks what is seen");
    if (result == GLBK_OK && gbuffer) result = glbk__csm_check_gbuffer(ctx, __func__, r, gbuffer);
    if (result != GLBK_OK) return result;
    memset(&frame, 0, sizeof frame);
    frame.frame_share = r->passes ? 1.0f / (float)r->frame_count : 0.0f;
    result = glbk__begin_picture(ctx, __func__, pass, picture, r->width, r->height, &r->resolve);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_csm_frame, &r->frame, &frame);
    if (result != GLBK_OK) return result;
    for (i = 0; i < 2; i++)
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_place + i, asks ? &gbuffer->words[i] : NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_sum, &r->sums[r->now]);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_read(glbk_context *ctx, glbk_csm_renderer *r, float *rgba)
{
    glbk_result result = glbk__require_created(ctx, __func__, "renderer", r ? &r->targets[0].name : NULL);
    size_t i, count;
    float scale;

    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "rgba", rgba);
    if (result != GLBK_OK) return result;
    if (!r->frame_count) return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "renderer", "has no frame yet");
    count = 4 * (size_t)r->width * r->height;
    if (!r->passes) {
        memset(rgba, 0, count * sizeof *rgba);
        return GLBK_OK;
    }
    result = glbk_target_read(ctx, &r->targets[r->now], 0, 0, 0, r->width, r->height, rgba);
    scale = 1.0f / (float)r->frame_count;
    for (i = 0; i < count && result == GLBK_OK; i++) rgba[i] *= scale;
    return result;
}
