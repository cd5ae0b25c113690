/* ---- csm: the renderer ---- */

/* Returns the kind of a light with the default resolved. */
static uint32_t glbk__csm_shape_of(const glbk_csm_use *u)
{
    return u->kind == LSAMP_LIGHT_DEFAULT ? (uint32_t)LSAMP_LIGHT_ENVIRONMENT : (uint32_t)u->kind;
}

/* Finds or compiles the program for a combination of shape, ask, filter and defines of maps. */
static glbk_result glbk__csm_shade_program(glbk_context *ctx, glbk_csm_renderer *r, const glbk_csm_use *use,
                                           uint32_t filter, glbk_program **out)
{
    char defines[] = "CSM_ASK=0 CSM_FILTER=0 COHSM_LOBES=1 CSM_SHAPE=10 CSM_PATTERNS";
    uint32_t shape = glbk__csm_shape_of(use), ask = (uint32_t)use->ask;
    defines[8] = (char)('0' + ask);
    defines[21] = (char)('0' + filter);
    defines[35] = (char)('0' + r->lobes);
    if (shape < 10) {
        defines[47] = (char)('0' + shape);
        defines[48] = ' ';
    }
    if (!r->patterns) defines[49] = 0;
    return glbk__csm_program(ctx, &r->shade, shape * 16 + ask * 4 + filter,
                             r->compute ? "csm_shade.comp" : "csm_shade.frag", 1, defines, use->maps, out);
}

/* Makes the sum, twice where passes draw from one into the other. */
static glbk_result glbk__csm_create_sums(glbk_context *ctx, glbk_csm_renderer *r)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result = GLBK_OK;
    int i;

    memset(&texture, 0, sizeof texture);
    texture.format = GLBK_FORMAT_COLOR;
    texture.width = r->width;
    texture.height = r->height;
    for (i = 0; i < (r->compute ? 1 : 2) && result == GLBK_OK; i++) {
        memset(&target, 0, sizeof target);
        result = glbk_texture_create(ctx, &texture, &r->sums[i]);
        target.color[0] = &r->sums[i];
        if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &r->targets[i]);
    }
    return result;
}

GLBK_DEF glbk_result glbk_csm_renderer_create(glbk_context *ctx, const glbk_csm_renderer_desc *d,
                                              glbk_csm_renderer *out)
{
    glbk_result result;

    if (!ctx || !out) return GLBK_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!d) return GLBK_ERR_ARGUMENT;
    if (!d->width || !d->height)
        return glbk__refuse(ctx, GLBK_ERR_DESC, __func__, d->width ? "desc.height" : "desc.width", "is 0");
    if (d->lobes > LSAMP_MAX_LOBES)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, __func__, "desc.lobes", d->lobes, 0, LSAMP_MAX_LOBES);
    out->width = d->width;
    out->height = d->height;
    out->compute = ctx->compute;
    out->lobes = d->lobes ? d->lobes : 1;
    out->patterns = d->patterns != 0;
    result = glbk__gbuffer_program(ctx, glbk_csm_part(), "csm_resolve.frag", NULL, &out->resolve);
    if (result == GLBK_OK) result = glbk__csm_create_sums(ctx, out);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_csm_frame), NULL, &out->frame);
    if (result != GLBK_OK) glbk_csm_renderer_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_csm_renderer_free(glbk_context *ctx, glbk_csm_renderer *r)
{
    uint32_t i;
    if (!r) return;
    glbk__csm_programs_free(ctx, &r->shade);
    glbk_program_free(ctx, &r->resolve);
    for (i = 0; i < 2; i++) {
        glbk_target_free(ctx, &r->targets[i]);
        glbk_texture_free(ctx, &r->sums[i]);
    }
    glbk_buffer_free(ctx, &r->frame);
    memset(r, 0, sizeof *r);
}

/* Checks a light of a frame. */
static glbk_result glbk__csm_check_use(const glbk_context *ctx, const char *function,
                                       const glbk_csm_renderer *r, const glbk_csm_lights *lights,
                                       const glbk_csm_use *u)
{
    const glbk__csm_logger log = glbk__csm_logger_make(ctx, function);
    const glbk_result bad = GLBK_ERR_DESC;
    if (!u->maps || !u->maps->blocks.name)
        return glbk__refuse(ctx, bad, function, "use.maps", "were not created");
    if ((unsigned)u->ask >= COHSM_LIGHT_COUNT)
        return glbk__refuse_value(ctx, bad, function, "use.ask", (double)u->ask, "a COHSM_LIGHT_...");
    if (!glbk__csm_kind_valid(&log, "use.kind", u->kind)) return bad;
    if (!u->samples || u->samples > 65536)
        return glbk__refuse_range(ctx, bad, function, "use.samples", u->samples, 1, 65536);
    if (u->start < 2 * lights->lobe_count || u->start >= lights->patterns_at)
        return glbk__refuse_value(ctx, bad, function, "use.start", u->start, "that of a light");
    if (r->patterns && u->samples != lights->pattern_length)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "use.samples", u->samples,
                                  "the patterns' length");
    return GLBK_OK;
}

/* Checks the desc of a frame. */
static glbk_result glbk__csm_check_frame(const glbk_context *ctx, const char *function,
                                         const glbk_csm_renderer *r, const glbk_csm_frame_desc *d)
{
    glbk_result bad = GLBK_ERR_DESC;
    uint32_t i;
    if (!ctx || !r || !r->targets[0].name || !d) return GLBK_ERR_ARGUMENT;
    if (!d->lights || !d->lights->texels.name)
        return glbk__refuse(ctx, bad, function, "desc.lights", "were not created");
    if (d->use_count && !d->uses) return glbk__refuse(ctx, bad, function, "desc.uses", "is NULL");
    if (d->plane_count > GLBK_CSM_MAX_PLANES)
        return glbk__refuse_range(ctx, bad, function, "desc.plane_count", d->plane_count, 0,
                                  GLBK_CSM_MAX_PLANES);
    if ((unsigned)d->sampling >= LSAMP_SAMPLING_COUNT)
        return glbk__refuse_value(ctx, bad, function, "desc.sampling", (double)d->sampling,
                                  "a LSAMP_SAMPLING_...");
    if ((unsigned)d->filter >= COHSM_FILTER_COUNT)
        return glbk__refuse_value(ctx, bad, function, "desc.filter", (double)d->filter, "a COHSM_FILTER_...");
    if (!glbk_csm__finite(d->bias)) return glbk__refuse(ctx, bad, function, "desc.bias", "is not finite");
    if (!(d->offset >= 0))
        return glbk__refuse_value(ctx, bad, function, "desc.offset", (double)d->offset, "0 or more");
    if (r->frames == UINT32_MAX)
        return glbk__refuse(ctx, GLBK_ERR_LIMIT, function, "renderer", "has 2^32 - 1 frames");
    for (i = 0, bad = GLBK_OK; i < d->use_count && bad == GLBK_OK; i++)
        bad = glbk__csm_check_use(ctx, function, r, d->lights, &d->uses[i]);
    return bad;
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
        result = glbk__csm_shade_program(ctx, r, &d->uses[i], (uint32_t)d->filter, &program);
    return result;
}

GLBK_DEF glbk_result glbk_csm_prepare(glbk_context *ctx, glbk_csm_renderer *r, const glbk_csm_frame_desc *d)
{
    return glbk__csm_prepare(ctx, __func__, r, d);
}

/* Checks that a G-buffer has the size of the renderer. */
static glbk_result glbk__csm_check_gbuffer(const glbk_context *ctx, const char *function,
                                           const glbk_csm_renderer *r, const glbk_gbuffer *g)
{
    if (!ctx || !r || !r->targets[0].name || !g || !g->colors.name) return GLBK_ERR_ARGUMENT;
    if (g->width == r->width && g->height == r->height) return GLBK_OK;
    return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "gbuffer.width or height",
                              g->width == r->width ? g->height : g->width, "that of the renderer");
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
        result = glbk__csm_shade_program(ctx, r, u, (uint32_t)d->filter, &program);
        frame.light_texel = u->start;
        frame.sample_count = u->samples;
        frame.seed = u->seed;
        frame.roulette_seed = u->seed * 0x9e3779b9u + d->frame * 0x85ebca6bu;
        for (from = 0; from < u->samples && result == GLBK_OK; from = frame.end) {
            frame.first = from;
            frame.end = u->samples - from < step ? u->samples : from + step;
            frame.adds = r->passes != 0;
            result = glbk__csm_shade_pass(ctx, r, gbuffer, u, d->lights, &frame, program);
        }
    }
    if (result == GLBK_OK) r->frames++;
    return result;
}

GLBK_DEF void glbk_csm_reset(glbk_csm_renderer *r)
{
    if (r) r->frames = r->passes = 0;
}

GLBK_DEF glbk_result glbk_csm_resolve(glbk_context *ctx, glbk_csm_renderer *r, const glbk_gbuffer *gbuffer,
                                      const glbk_pass *pass, const glbk_picture *picture)
{
    const int asks = picture && (picture->keep_empty || picture->world_to_clip);
    glbk_csm_frame frame;
    glbk_result result = GLBK_OK;
    uint32_t i;

    if (!ctx || !r || !r->resolve.name || !pass) return GLBK_ERR_ARGUMENT;
    if (asks && !gbuffer)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "picture",
                            "asks what is seen, but gbuffer is NULL");
    if (gbuffer) result = glbk__csm_check_gbuffer(ctx, __func__, r, gbuffer);
    if (result != GLBK_OK) return result;
    memset(&frame, 0, sizeof frame);
    frame.frame_share = r->passes ? 1.0f / (float)r->frames : 0.0f;
    result = glbk__begin_picture(ctx, pass, picture, r->width, r->height, &r->resolve);
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
    glbk_result result;
    size_t i, count;
    float scale;

    if (!ctx || !r || !r->targets[0].name || !rgba) return GLBK_ERR_ARGUMENT;
    if (!r->frames) return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "renderer", "has no frame yet");
    count = 4 * (size_t)r->width * r->height;
    if (!r->passes) {
        memset(rgba, 0, count * sizeof *rgba);
        return GLBK_OK;
    }
    result = glbk_target_read(ctx, &r->targets[r->now], 0, 0, 0, r->width, r->height, rgba);
    scale = 1.0f / (float)r->frames;
    for (i = 0; i < count && result == GLBK_OK; i++) rgba[i] *= scale;
    return result;
}
