/* ---- csm: questions in bulk ---- */

/* Finds or compiles the program for the questions that were uploaded and these maps. */
static glbk_result glbk__csm_ask_program(glbk_context *ctx, glbk_csm_asker *asker, const glbk_csm_maps *maps,
                                         glbk_program **out)
{
    char defines[] = "CSM_ASK=0 CSM_FILTER=0";
    const char *texts[2];
    uint32_t question = asker->question - 1;
    texts[0] = defines;
    texts[1] = NULL;
    asker->programs.frame++;
    defines[8] = (char)('0' + question / 3);
    defines[21] = (char)('0' + question % 3);
    return glbk__csm_program(ctx, "glbk_csm_ask_run", &asker->programs, question,
                             asker->asked.name ? "csm_query.comp" : "csm_query.frag", texts, maps, out);
}

GLBK_DEF glbk_result glbk_csm_asker_create(glbk_context *ctx, uint32_t capacity, glbk_csm_asker *out)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result;

    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result != GLBK_OK) return result;
    if (!capacity || capacity > (uint32_t)1 << 22)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "capacity", capacity, 1, 4194304);
    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    out->capacity = capacity;
    result = glbk_buffer_create(ctx, sizeof(glbk_csm_frame), NULL, &out->frame);
    if (result == GLBK_OK && ctx->compute && 32 * (size_t)capacity <= ctx->max_storage) {
        result = glbk_buffer_create(ctx, 32 * (size_t)capacity, NULL, &out->asked);
        if (result == GLBK_OK) result = glbk_buffer_create(ctx, 4 * (size_t)capacity, NULL, &out->answered);
    } else if (result == GLBK_OK) {
        result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, 2 * (size_t)capacity, &out->questions);
        texture.format = GLBK_FORMAT_R32UI;
        texture.width = 1024;
        texture.height = (capacity + 1023) / 1024;
        if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &out->answers);
        target.color[0] = &out->answers;
        if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &out->target);
    }
    if (result != GLBK_OK) glbk_csm_asker_free(ctx, out);
    return result;
}

/* Checks what glbk_csm_ask_upload is given. */
static glbk_result glbk__csm_check_query(const glbk_context *ctx, const glbk_csm_asker *asker,
                                         const cohsm_query *q)
{
    static const char function[] = "glbk_csm_ask_upload";
    const glbk_result bad = GLBK_ERR_ARGUMENT;
    glbk_result result = glbk__require_created(ctx, function, "asker", asker ? &asker->frame.name : NULL);
    size_t least, stride;

    if (result == GLBK_OK) result = glbk__require(ctx, function, "query", q);
    if (result == GLBK_OK) result = glbk__require(ctx, function, "query.positions", q->positions);
    if (result == GLBK_OK) result = glbk__require(ctx, function, "query.lights", q->lights);
    if (result != GLBK_OK) return result;
    least = q->light_kind == COHSM_LIGHT_INDEX ? 4 : 12;
    stride = q->light_stride;
    if (!q->count || q->count > asker->capacity)
        return glbk__refuse_range(ctx, q->count ? GLBK_ERR_LIMIT : bad, function, "query.count",
                                  (double)q->count, 1, asker->capacity);
    if (q->position_stride % 4 || (q->position_stride && q->position_stride < 12))
        return glbk__refuse_value(ctx, bad, function, "query.position_stride", (double)q->position_stride,
                                  "0 or a multiple of 4, >= 12");
    if ((unsigned)q->light_kind >= COHSM_LIGHT_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "query.light_kind", (double)q->light_kind,
                                  "a COHSM_LIGHT_...");
    if (stride % 4 || (stride && stride < least) || (!stride && q->light_kind == COHSM_LIGHT_PARAMETER))
        return glbk__refuse_value(ctx, bad, function, "query.light_stride", (double)stride,
                                  q->light_kind == COHSM_LIGHT_PARAMETER
                                      ? "a multiple of 4, >= 12"
                                      : "0 or a multiple of 4, >= a light");
    if ((unsigned)q->filter >= COHSM_FILTER_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "query.filter", (double)q->filter,
                                  "a COHSM_FILTER_...");
    if (!glbk_csm__finite(q->bias))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "query.bias", (double)q->bias, "finite");
    return GLBK_OK;
}

/* Returns a bias with its default resolved, as csm.h has it: 0 is a pixel, a negative one none. */
static float glbk__csm_bias(float bias) { return bias > 0 ? bias : bias < 0 ? 0.0f : 1.0f; }

/* Writes eight words for each question: the point as 3 floats and its instance; the light as 3 floats or a
   cell, and a number for roulette. */
static void glbk__csm_write_questions(const cohsm_query *q, uint32_t *words)
{
    const size_t bytes = q->light_kind == COHSM_LIGHT_INDEX ? 4 : 12,
                 step = q->light_stride ? q->light_stride : bytes;
    const size_t stride = q->position_stride ? q->position_stride : 12;
    size_t i;
    memset(words, 0, 32 * q->count);
    for (i = 0; i < q->count; i++, words += 8) {
        memcpy(words, (const char *)q->positions + i * stride, 12);
        words[3] = q->entities ? q->entities[i] : 0;
        memcpy(words + 4, (const char *)q->lights + (q->one_light ? 0 : i * step), bytes);
        words[7] = (uint32_t)i;
    }
}

GLBK_DEF glbk_result glbk_csm_ask_upload(glbk_context *ctx, glbk_csm_asker *asker, const cohsm_query *q)
{
    glbk_csm__allocator memory;
    glbk_csm_frame frame;
    glbk_result result;
    uint32_t *words;

    result = glbk__csm_check_query(ctx, asker, q);
    if (result != GLBK_OK) return result;
    memory = glbk_csm__memory(ctx);
    words = (uint32_t *)glbk_csm__alloc_array(&memory, q->count, 32);
    if (!words) return GLBK_ERR_ALLOC;
    glbk__csm_write_questions(q, words);
    asker->question = 1 + 3 * (uint32_t)q->light_kind + (uint32_t)q->filter;
    memset(&frame, 0, sizeof frame);
    frame.end = (uint32_t)q->count;
    frame.roulette_seed = q->seed;
    frame.bias = glbk__csm_bias(q->bias);
    result = glbk_buffer_update(ctx, &asker->frame, 0, sizeof frame, &frame);
    if (result == GLBK_OK)
        result = asker->asked.name ? glbk_buffer_update(ctx, &asker->asked, 0, 32 * q->count, words)
                                   : glbk__table_update(ctx, &asker->questions, 0, 2 * q->count, words);
    glbk_csm__free(&memory, words);
    return result;
}

GLBK_DEF glbk_result glbk_csm_ask_run(glbk_context *ctx, glbk_csm_asker *asker, const glbk_csm_maps *maps,
                                      uint32_t count)
{
    glbk_pass pass;
    glbk_program *program;
    glbk_result result;
    uint32_t groups = (count + 63) / 64;

    result = glbk__require_created(ctx, __func__, "asker", asker ? &asker->frame.name : NULL);
    if (result == GLBK_OK)
        result = glbk__require_created(ctx, __func__, "maps", maps ? &maps->blocks.name : NULL);
    if (result != GLBK_OK) return result;
    if (!count || count > asker->capacity)
        return glbk__refuse_range(ctx, count ? GLBK_ERR_LIMIT : GLBK_ERR_ARGUMENT, __func__, "count", count,
                                  1, asker->capacity);
    if (!asker->question) return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "asker", "has no questions yet");
    result = glbk__csm_ask_program(ctx, asker, maps, &program);
    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    if (!asker->asked.name) {
        pass.target = &asker->target;
        pass.viewport[2] = 1024;
        pass.viewport[3] = (int32_t)((count + 1023) / 1024);
        result = glbk_begin(ctx, &pass, program);
        if (result != GLBK_OK) return result;
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_questions, &asker->questions);
    }
    glbk_csm_bind(ctx, maps, NULL);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_csm_frame, &asker->frame);
    if (!asker->asked.name) {
        glbk_draw_screen(ctx);
        return GLBK_OK;
    }
    glbk_bind_storage(ctx, GLBK_SLOT_glbk_csm_asked, &asker->asked);
    glbk_bind_storage(ctx, GLBK_SLOT_glbk_csm_answers, &asker->answered);
    return glbk_dispatch(ctx, program, groups < 1024 ? groups : 1024, (groups + 1023) / 1024, 1);
}

GLBK_DEF glbk_result glbk_csm_ask_read(glbk_context *ctx, glbk_csm_asker *asker, uint32_t count,
                                       float *visible)
{
    uint32_t row[4 * 1024], done, n, i;
    glbk_result result = glbk__require_created(ctx, __func__, "asker", asker ? &asker->frame.name : NULL);

    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "visible", visible);
    if (result != GLBK_OK) return result;
    if (!count || count > asker->capacity)
        return glbk__refuse_range(ctx, count ? GLBK_ERR_LIMIT : GLBK_ERR_ARGUMENT, __func__, "count", count,
                                  1, asker->capacity);
    if (asker->asked.name) return glbk_buffer_read(ctx, &asker->answered, 0, 4 * (size_t)count, visible);
    for (done = 0; done < count && result == GLBK_OK; done += n) {
        n = count - done < 1024 ? count - done : 1024;
        result = glbk_target_read(ctx, &asker->target, 0, 0, done / 1024, n, 1, row);
        for (i = 0; i < n && result == GLBK_OK; i++) memcpy(visible + done + i, row + 4 * i, 4);
    }
    return result;
}

GLBK_DEF void glbk_csm_asker_free(glbk_context *ctx, glbk_csm_asker *asker)
{
    if (!asker) return;
    glbk__csm_programs_free(ctx, &asker->programs);
    glbk_target_free(ctx, &asker->target);
    glbk_texture_free(ctx, &asker->questions);
    glbk_texture_free(ctx, &asker->answers);
    glbk_buffer_free(ctx, &asker->frame);
    glbk_buffer_free(ctx, &asker->asked);
    glbk_buffer_free(ctx, &asker->answered);
    memset(asker, 0, sizeof *asker);
}
