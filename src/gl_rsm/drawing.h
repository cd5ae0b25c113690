/* ---- rsm: drawing maps ---- */

/* Sets the block of a surface. A map then has the albedo that lib/gbuffer.glsl reads after
   glbk_gbuffer_object. */
static void glbk__rsm_set_surface(glbk_rsm_drawn *drawn, const glbk_surface *s)
{
    const lsamp_material *m = &s->material;
    const float share = m->kind == LSAMP_MATERIAL_METAL_ROUGH ? 1.0f - m->metallic : 1.0f;
    int i, zero = 1;
    for (i = 0; i < 16; i++) zero = zero && !(fabsf(s->transform[i]) > 0.0f);
    memcpy(drawn->transform, s->transform, sizeof drawn->transform);
    if (zero) drawn->transform[0] = drawn->transform[5] = drawn->transform[10] = drawn->transform[15] = 1.0f;
    for (i = 0; i < 3; i++) drawn->albedo[i] = m->diffuse[i] * share;
    drawn->alpha_cutoff = s->alpha_cutoff / (s->alpha > 0.0f ? s->alpha : 1.0f);
}

GLBK_DEF glbk_result glbk_rsm_object(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_surface *s,
                                     uint32_t material)
{
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_renderer_check(ctx, __func__, r);
    if (result != GLBK_OK) return result;
    if (!s) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "surface", "is NULL");
    if (!r->drawing)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "the call", "comes from no glbk_rsm_draw_fn");
    glbk__rsm_set_surface(&r->drawn, s);
    r->drawn.material = material;
    r->drawn.has_map = s->color_map != NULL;
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_rsm_drawn, &r->object, &r->drawn);
    if (result != GLBK_OK) {
        if (r->failed == GLBK_OK) r->failed = result;
        return result;
    }
    if (s->color_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_albedo_map, s->color_map);
    return GLBK_OK;
}

/* Clears a face and lets the user's function draw into it. */
static glbk_result glbk__rsm_fill(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_target *target,
                                  const glbk_rsm_map *map, glbk_rsm_draw_fn draw_fn, void *user)
{
    static const uint32_t empty[4] = { 0, 0, 0, 0 }, place[4] = { 0, 0, 0, GLBK__RSM_FAR_BITS };
    glbk_pass pass;
    glbk_result result = glbk__rsm_program(ctx, r, GLBK__RSM_FILL);
    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_begin(ctx, &pass, &r->programs[GLBK__RSM_FILL]);
    if (result != GLBK_OK) return result;
    ctx->gl.ClearBufferuiv(GLBK_GL_COLOR, 0, place);
    ctx->gl.ClearBufferuiv(GLBK_GL_COLOR, 1, empty);
    ctx->gl.ClearBufferuiv(GLBK_GL_COLOR, 2, empty);
    glbk_clear_depth(ctx, 1);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_rsm_light, &map->buffer);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_albedo_map, NULL);        /* Objects bind theirs. */
    r->drawing = 1;
    r->failed = GLBK_OK;
    draw_fn(user, ctx, r);
    r->drawing = 0;
    return r->failed != GLBK_OK ? r->failed : ctx->lost ? GLBK_ERR_LOST : glbk__leave_frame(ctx);
}

GLBK_DEF glbk_result glbk_rsm_map_draw(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map,
                                       glbk_rsm_draw_fn draw_fn, void *user)
{
    glbk_result result;
    uint32_t face;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_renderer_check(ctx, __func__, r);
    if (result == GLBK_OK) result = glbk__rsm_map_check(ctx, __func__, map);
    if (result != GLBK_OK) return result;
    if (!draw_fn) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "draw_fn", "is NULL");
    memset(&r->drawn, 0, sizeof r->drawn);
    if (map->light.kind == RSM_LIGHT_SUN)
        glbk__rsm_set4(r->drawn.eye, glbk_rsm__v3_scale(glbk_rsm__v3_load(map->block.axis), -1), 0);
    else glbk__rsm_set4(r->drawn.eye, glbk_rsm__v3_load(map->light.position), 1);
    r->drawn.near_depth = map->light.near_depth;
    r->drawn.depth_scale = 1.0f / (map->light.far_depth - map->light.near_depth);
    map->summed = 0;
    for (face = 0; face < map->face_count && result == GLBK_OK; face++) {
        glbk__rsm_face_matrix(map, face, r->drawn.clip);
        r->drawn.face = face;
        result = glbk__rsm_fill(ctx, r, &map->face_targets[face], map, draw_fn, user);
    }
    return result;
}
