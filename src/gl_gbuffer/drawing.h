/* ---- gbuffer: drawing ---- */

enum { GLBK__DRAWN_COLOR_MAP = 1, GLBK__DRAWN_GLOSS_MAP = 2, GLBK__DRAWN_NORMAL_MAP = 4 };

/* Compiles the program that draws objects, for the locations of the G-buffer's attributes, unless there is
   one. */
static glbk_result glbk__gbuffer_draw_program(glbk_context *ctx, glbk_gbuffer *g)
{
    if (g->draw_program.name) return GLBK_OK;
    return glbk__drawing_program(ctx, glbk_gbuffer_part(), "gbuffer_draw.frag", &g->attributes, "",
                                 &g->draw_program);
}

/* Binds a target of the G-buffer with a program, and clears its textures to 0 and its depth, if any, to 1. */
static glbk_result glbk__gbuffer_start(glbk_context *ctx, const glbk_target *target, glbk_depth depth,
                                       glbk_program *program)
{
    static const float zero[4] = { 0, 0, 0, 0 };
    glbk_pass pass;
    glbk_result result;
    uint32_t i;

    memset(&pass, 0, sizeof pass);
    pass.target = target;
    pass.depth = depth;
    result = glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    for (i = 0; i < 4; i++) glbk_clear(ctx, target, i, zero);
    if (depth != GLBK_DEPTH_OFF) glbk_clear_depth(ctx, 1);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_gbuffer_begin(glbk_context *ctx, glbk_gbuffer *g, const float world_to_clip[16],
                                        const float eye[3])
{
    glbk_result result;
    uint32_t i;

    result = glbk__require_created(ctx, __func__, "gbuffer", g ? &g->target.name : NULL);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "world_to_clip", world_to_clip);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "eye", eye);
    if (result == GLBK_OK) result = glbk__gbuffer_draw_program(ctx, g);
    if (result == GLBK_OK) result = glbk__gbuffer_start(ctx, &g->target, GLBK_DEPTH_LESS, &g->draw_program);
    if (result != GLBK_OK) return result;
    /* The program declares the samplers of maps, which an object without maps leaves as they are. */
    for (i = 0; i < 3; i++) glbk_bind_texture(ctx, GLBK_SLOT_glbk_gbuffer_color_map + i, NULL);
    memcpy(g->world_to_clip, world_to_clip, sizeof g->world_to_clip);
    memcpy(g->eye, eye, sizeof g->eye);
    g->has_depth = g->has_clip = 1;
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_gbuffer_object(glbk_context *ctx, glbk_gbuffer *g, const glbk_surface *s)
{
    glbk_gbuffer_drawn drawn;
    glbk_result result;

    result = glbk__require_created(ctx, __func__, "gbuffer", g ? &g->target.name : NULL);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "surface", s);
    if (result != GLBK_OK) return result;
    if (!g->draw_program.name || !g->has_clip)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "gbuffer", "was not begun: glbk_gbuffer_begin");
    if (!glbk__gbuffer_material_valid(ctx, __func__, &s->material, s->plane, s->occlusion))
        return GLBK_ERR_DESC;
    memset(&drawn, 0, sizeof drawn);
    memcpy(drawn.transform, glbk_gbuf__m4_or_identity(s->transform), sizeof drawn.transform);
    memcpy(drawn.clip, g->world_to_clip, sizeof drawn.clip);
    memcpy(drawn.eye, g->eye, sizeof g->eye);
    memcpy(drawn.diffuse, s->material.diffuse, sizeof s->material.diffuse);
    drawn.diffuse[3] = s->alpha > 0 ? s->alpha : 1.0f;
    drawn.alpha_cutoff = s->alpha_cutoff;
    drawn.occlusion = s->occlusion;
    drawn.kind = glbk__gbuffer_kind(&s->material);
    drawn.entity = s->entity;
    drawn.plane = s->plane;
    drawn.first_lobe = s->first_lobe;
    drawn.lobe_count = s->material.lobe_count;
    if (s->color_map) drawn.maps |= GLBK__DRAWN_COLOR_MAP;
    if (s->gloss_map) drawn.maps |= GLBK__DRAWN_GLOSS_MAP;
    if (s->normal_map) drawn.maps |= GLBK__DRAWN_NORMAL_MAP;
    glbk__gbuffer_gloss(&s->material, drawn.gloss);
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_gbuffer_drawn, &g->drawn, &drawn);
    if (result != GLBK_OK) return result;
    if (s->color_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_gbuffer_color_map, s->color_map);
    if (s->gloss_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_gbuffer_gloss_map, s->gloss_map);
    if (s->normal_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_gbuffer_normal_map, s->normal_map);
    return GLBK_OK;
}
