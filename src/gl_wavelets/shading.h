/* ---- wavelets: the passes of a batch of points ---- */

/* Begins a pass of a batch: draws cover `width` x `height` texels of a target, from (left, bottom) on. */
static glbk_result glbk__haar_pass(glbk_context *ctx, const glbk_sfield_haar *h, glbk_program *program,
                                   const glbk_target *target, const uint32_t viewport[4])
{
    glbk_pass pass;
    glbk_result result;
    int i;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    for (i = 0; i < 4; i++) pass.viewport[i] = (int32_t)viewport[i];
    result = glbk_begin(ctx, &pass, program);
    if (result == GLBK_OK) glbk_bind_block(ctx, GLBK_SLOT_glbk_haar_batch, &h->block);
    return result;
}

/* Binds what passes read of a list. */
static void glbk__haar_bind(glbk_context *ctx, const glbk_sfield_haar *h, const glbk_sfield_scene *s)
{
    glbk_sfield_bind(ctx, s, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_what, &h->list[0]);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_corner, &h->list[1]);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_weight, &h->list[2]);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_cubes, &h->cubes);
}

/* Draws a round of a batch: lists, their cubes, and what T and light come to. */
static glbk_result glbk__haar_round(glbk_context *ctx, glbk_sfield_haar *h, const glbk_gbuffer *g,
                                    const glbk_sfield_scene *s, const glbk_haar_batch *b)
{
    const uint32_t now = b->round & 1, half = h->cube_side / 2, cubes = b->count * b->slots;
    const uint32_t lists[4] = { 0, 0, b->slots, b->count },
                   squares[4] = { 0, 0, h->columns * 6 * half, (cubes + h->columns - 1) / h->columns * half },
                   strips[4] = { 0, 0, h->columns * 6 * half,
                                 (b->count + 2 * h->columns - 1) / (2 * h->columns) * half };
    glbk_result result = glbk__put_block(ctx, GLBK_SLOT_glbk_haar_batch, &h->block, b);
    if (result == GLBK_OK) result = glbk__haar_pass(ctx, h, &h->find, &h->list_target[now], lists);
    if (result != GLBK_OK) return result;
    glbk_sfield_bind(ctx, s, NULL);
    result = glbk_gbuffer_bind(ctx, g, NULL);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_self, &h->self);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_met, b->round ? &h->met[!now] : NULL);
    glbk_draw_screen(ctx);
    result = glbk__haar_pass(ctx, h, &h->write, &h->cubes_target, squares);
    if (result != GLBK_OK) return result;
    glbk__haar_bind(ctx, h, s);
    result = glbk_gbuffer_bind(ctx, g, NULL);
    if (result != GLBK_OK) return result;
    glbk_draw_screen(ctx);
    result = glbk__haar_pass(ctx, h, &h->multiply, &h->left_target[now], strips);
    if (result != GLBK_OK) return result;
    glbk__haar_bind(ctx, h, s);
    result = glbk_gbuffer_bind(ctx, g, NULL);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_lower, b->round ? &h->left[!now][0] : NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_upper, b->round ? &h->left[!now][1] : NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_sums, b->round ? &h->left[!now][2] : NULL);
    if (h->has_gloss)
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_shine, b->round ? &h->left[!now][3] : NULL);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Shades the points of a batch by compute. */
static glbk_result glbk__haar_dispatch(glbk_context *ctx, glbk_sfield_haar *h, const glbk_gbuffer *g,
                                       const glbk_sfield_scene *s, const glbk_haar_batch *b)
{
    glbk_result result = glbk__put_block(ctx, GLBK_SLOT_glbk_haar_batch, &h->block, b);
    if (result != GLBK_OK) return result;
    glbk_sfield_bind(ctx, s, NULL);
    result = glbk_gbuffer_bind(ctx, g, NULL);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_self, &h->self);
    glbk_bind_storage(ctx, GLBK_SLOT_glbk_haar_left, &h->kept);
    glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_light_image, &h->light);
    if (h->has_gloss) glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_gloss_image, &h->gloss);
    return glbk_dispatch(ctx, &h->shade, b->width, b->count / b->width, 1);
}

/* Shades the points of a batch, whose rectangle is set, in so many rounds. sky: not 0 if the sky or the open
   share is wanted. */
static glbk_result glbk__haar_batch(glbk_context *ctx, glbk_sfield_haar *h, const glbk_gbuffer *g,
                                    const glbk_sfield_scene *s, uint32_t rounds, int sky,
                                    glbk_haar_batch *b)
{
    const uint32_t pixels[4] = { b->left, b->bottom, b->width, b->count / b->width };
    glbk_result result = GLBK_OK;
    b->last = sky != 0;
    if (h->compute) return glbk__haar_dispatch(ctx, h, g, s, b);
    for (b->round = 0; b->round < rounds && result == GLBK_OK; b->round++) {
        b->last = sky && b->round + 1 == rounds;
        result = glbk__haar_round(ctx, h, g, s, b);
    }
    if (result == GLBK_OK) result = glbk__haar_pass(ctx, h, &h->sum, &h->target, pixels);
    if (result != GLBK_OK) return result;
    glbk_sfield_bind(ctx, s, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_sums, &h->left[!(rounds & 1)][2]);
    if (h->has_gloss) {
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_shine, &h->left[!(rounds & 1)][3]);
        result = glbk_gbuffer_bind(ctx, g, NULL);
        if (result != GLBK_OK) return result;
    }
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_sfield_haar_shade(glbk_context *ctx, glbk_sfield_haar *h, const glbk_gbuffer *g,
                                            const glbk_sfield_scene *s, const float eye[3], int open)
{
    glbk_sfield_contents contents;
    glbk_haar_batch b;
    glbk_result result;
    uint32_t most, wide, high;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__haar_check_pair(ctx, __func__, h, s);
    if (result == GLBK_OK) result = glbk__sfield_check_gbuffer(ctx, __func__, h->width, h->height, g);
    if (result != GLBK_OK) return result;
    if (h->self_of && h->self_of != s->key)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "scene",
                            "is not the one of glbk_sfield_haar_self");
    if (!eye && g->has_clip) eye = g->eye;
    if (h->has_gloss && !eye)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "eye",
                            "is NULL: lobes need it, and the G-buffer has none");
    most = s->entity_count + 3 * s->light_count + (h->self_of ? 1u : 0u);
    memset(&b, 0, sizeof b);
    if (eye) memcpy(b.eye, eye, 12);
    b.slots = most < GLBK__HAAR_SLOTS ? (most ? most : 1) : (uint32_t)GLBK__HAAR_SLOTS;
    b.own = h->self_of != 0;
    b.side = h->cube_side;
    b.columns = h->columns;
    contents = glbk__sfield_contents_of(s, s->sky || open);
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_sfield_contents, &s->contents, &contents);
    wide = h->width < h->batch ? h->width : h->batch;
    if (wide > 32 && !h->compute) wide = 32;    /* points that are near each other read the same samples */
    high = h->batch / wide;
    for (b.bottom = 0; b.bottom < h->height && result == GLBK_OK; b.bottom += high)
        for (b.left = 0; b.left < h->width && result == GLBK_OK; b.left += wide) {
            const uint32_t rows = h->height - b.bottom < high ? h->height - b.bottom : high;
            b.width = h->width - b.left < wide ? h->width - b.left : wide;
            b.count = b.width * rows;
            result = glbk__haar_batch(ctx, h, g, s, most ? (most + b.slots - 1) / b.slots : 1,
                                      s->sky || open, &b);
        }
    return result;
}
