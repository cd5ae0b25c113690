/* ---- gbuffer: from textures of the user's own ---- */

/* Bits of the block's `given`, as gbuffer_import.frag has them. */
enum {
    GLBK__IMPORT_PLACES = 1, GLBK__IMPORT_DEPTH = 2, GLBK__IMPORT_FLAT = 4, GLBK__IMPORT_COLORS = 8,
    GLBK__IMPORT_GLOSS = 16, GLBK__IMPORT_OPEN = 32, GLBK__IMPORT_ENTITIES = 64, GLBK__IMPORT_REVERSED = 128
};

/* Inverts a matrix by elimination with pivots, in double; returns 0 if it has no inverse. */
static int glbk__gbuffer_invert(const float *from, float *to)
{
    double m[4][8], keep;
    int c, r, k, best;

    for (r = 0; r < 4; r++)
        for (c = 0; c < 4; c++) {
            m[r][c] = (double)from[4 * c + r];
            m[r][4 + c] = r == c ? 1 : 0;
        }
    for (c = 0; c < 4; c++) {
        best = c;
        for (r = c + 1; r < 4; r++)
            if (fabs(m[r][c]) > fabs(m[best][c])) best = r;
        if (!(fabs(m[best][c]) > 1e-30)) return 0;
        for (k = 0; k < 8; k++) {
            keep = m[best][k];
            m[best][k] = m[c][k];
            m[c][k] = keep;
        }
        for (k = 7; k >= c; k--) m[c][k] /= m[c][c];
        for (r = 0; r < 4; r++)
            for (k = 7; r != c && k >= c; k--) m[r][k] -= m[r][c] * m[c][k];
    }
    for (r = 0; r < 4; r++)
        for (c = 0; c < 4; c++) to[4 * c + r] = (float)m[r][4 + c];
    return 1;
}

/* Checks that each texture of the user's is not given or is a 2D texture of the right size. */
static glbk_result glbk__gbuffer_check_textures(const glbk_context *ctx, const glbk_gbuffer *g,
                                                const glbk_import *d)
{
    static const char *const names[8] = { "import.depth", "import.positions", "import.normals",
                                          "import.geometric_normals", "import.color_map", "import.gloss_map",
                                          "import.open_map", "import.entities" };
    const glbk_texture *const textures[8] = { d->depth, d->positions, d->normals, d->geometric_normals,
                                              d->color_map, d->gloss_map, d->open_map, d->entities };
    const char *text = NULL;
    int i;
    for (i = 0; i < 8; i++) {
        const glbk_texture *t = textures[i];
        if (!t) continue;
        if (!t->name || t->layers)
            return glbk__gbuffer_bad(ctx, "glbk_gbuffer_import", names[i],
                                     t->name ? "is an array, not 2D" : "has no name of GL");
        if (t->width != g->width) text = "has not the width of the G-buffer";
        else if (t->height != g->height) text = "has not the height of the G-buffer";
        if (text) return glbk__refuse(ctx, GLBK_ERR_MISMATCH, "glbk_gbuffer_import", names[i], text);
    }
    return GLBK_OK;
}

/* Checks that an import can be done. */
static glbk_result glbk__gbuffer_check_import(const glbk_context *ctx, const glbk_gbuffer *g,
                                              const glbk_import *d)
{
    const char *const function = "glbk_gbuffer_import";
    glbk_result result;
    if (!d->normals || (!d->depth && !d->positions))
        return glbk__gbuffer_bad(ctx, function, d->normals ? "import.depth" : "import.normals",
                                 d->normals ? "and import.positions are NULL; one is needed" : "is NULL");
    if (d->depth && !d->positions && glbk__gbuffer_is_zero(d->world_to_clip, 16))
        return glbk__gbuffer_bad(ctx, function, "import.world_to_clip",
                                 "is needed for places by their depths");
    result = glbk__gbuffer_check_textures(ctx, g, d);
    if (result != GLBK_OK) return result;
    return glbk__gbuffer_within(ctx, function, "import.clip_depth", d->clip_depth, 0,
                                GLBK_CLIP_DEPTH_COUNT - 1) &&
                   glbk__gbuffer_within(ctx, function, "import.normal_packing", d->normal_packing, 0,
                                        GLBK_NORMAL_PACKING_COUNT - 1) &&
                   glbk__gbuffer_material_valid(ctx, function, &d->material, d->plane, d->occlusion)
               ? GLBK_OK
               : GLBK_ERR_DESC;
}

/* Writes world to clip space in OpenGL's convention, with depths -1..1. */
static void glbk__gbuffer_clip(const glbk_import *d, float clip[16])
{
    const int reversed = d->clip_depth == GLBK_CLIP_DEPTH_REVERSED;
    int c;
    memcpy(clip, d->world_to_clip, sizeof d->world_to_clip);
    if (!reversed && d->clip_depth != GLBK_CLIP_DEPTH_ZERO_TO_ONE) return;
    for (c = 0; c < 4; c++)
        clip[4 * c + 2] =
            reversed ? clip[4 * c + 3] - 2 * clip[4 * c + 2] : 2 * clip[4 * c + 2] - clip[4 * c + 3];
}

/* Returns which textures there are, as bits. */
static uint32_t glbk__gbuffer_given(const glbk_import *d)
{
    uint32_t bits = 0;
    if (d->positions) bits |= GLBK__IMPORT_PLACES;
    if (d->depth) bits |= GLBK__IMPORT_DEPTH;
    if (d->geometric_normals) bits |= GLBK__IMPORT_FLAT;
    if (d->color_map) bits |= GLBK__IMPORT_COLORS;
    if (d->gloss_map) bits |= GLBK__IMPORT_GLOSS;
    if (d->open_map) bits |= GLBK__IMPORT_OPEN;
    if (d->entities) bits |= GLBK__IMPORT_ENTITIES;
    if (d->clip_depth == GLBK_CLIP_DEPTH_REVERSED) bits |= GLBK__IMPORT_REVERSED;
    return bits;
}

/* Fills the block of an import, all but from_clip. */
static void glbk__gbuffer_fill_import(const glbk_gbuffer *g, const glbk_import *d, glbk_gbuffer_imported *out)
{
    const int full_range =
        d->clip_depth != GLBK_CLIP_DEPTH_REVERSED && d->clip_depth != GLBK_CLIP_DEPTH_ZERO_TO_ONE;

    glbk__gbuffer_clip(d, out->to_clip);
    memcpy(out->to_world, glbk_gbuf__m4_or_identity(d->to_world), sizeof out->to_world);
    out->kind = glbk__gbuffer_kind(&d->material);
    out->entity = d->entity;
    out->plane = d->plane;
    out->occlusion = d->occlusion;
    out->first_lobe = d->first_lobe;
    out->lobe_count = d->material.lobe_count;
    out->given = glbk__gbuffer_given(d);
    out->normal_packing = (uint32_t)d->normal_packing;
    out->width = g->width;
    out->height = g->height;
    memcpy(out->diffuse, d->material.diffuse, sizeof d->material.diffuse);
    glbk__gbuffer_gloss(&d->material, out->gloss);
    memcpy(out->eye, d->eye, sizeof d->eye);
    out->depth_scale = full_range ? 2.0f : 1.0f;
    out->depth_offset = full_range ? -1.0f : 0.0f;
}

/* Binds a texture of the user's, whose glbk_texture need not have gl_target; NULL binds none. */
static void glbk__gbuffer_bind_in(glbk_context *ctx, uint32_t slot, const glbk_texture *texture)
{
    glbk_texture t;
    memset(&t, 0, sizeof t);
    if (texture) t = *texture;
    t.gl_target = GLBK_GL_TEXTURE_2D;
    glbk_bind_texture(ctx, slot, &t);
}

static void glbk__gbuffer_bind_import(glbk_context *ctx, const glbk_import *d)
{
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_color_map, d->color_map);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_gloss_map, d->gloss_map);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_place_in, d->positions);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_depth_in, d->depth);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_normal_in, d->normals);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_flat_in, d->geometric_normals);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_open_in, d->open_map);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_entity_in, d->entities);
}

GLBK_DEF glbk_result glbk_gbuffer_import(glbk_context *ctx, glbk_gbuffer *g, const glbk_import *d)
{
    glbk_gbuffer_imported block;
    glbk_result result = glbk__require_created(ctx, __func__, "gbuffer", g ? &g->target.name : NULL);
    int own;

    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "import", d);
    if (result == GLBK_OK) result = glbk__gbuffer_check_import(ctx, g, d);
    if (result != GLBK_OK) return result;
    own = g->own_depth;
    memset(&block, 0, sizeof block);
    g->has_clip = !glbk__gbuffer_is_zero(d->world_to_clip, 16);
    if (g->has_clip && !glbk__gbuffer_invert(d->world_to_clip, block.from_clip))
        return glbk__gbuffer_bad(ctx, __func__, "import.world_to_clip", "has no inverse");
    glbk__gbuffer_fill_import(g, d, &block);
    if (!g->import_program.name)
        result = glbk__program_create(ctx, glbk_gbuffer_part(), "gbuffer_import.frag",
                                     own ? "GBUFFER_DEPTH=1" : "GBUFFER_DEPTH=0", &g->import_program);
    if (result == GLBK_OK)
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_gbuffer_imported, &g->imported, &block);
    if (result == GLBK_OK)
        result = glbk__gbuffer_start(ctx, own ? &g->target : &g->colors,
                                     own ? GLBK_DEPTH_LESS : GLBK_DEPTH_OFF, &g->import_program);
    if (result != GLBK_OK) return result;
    glbk__gbuffer_bind_import(ctx, d);
    glbk_draw_screen(ctx);
    memcpy(g->world_to_clip, block.to_clip, sizeof g->world_to_clip);
    memcpy(g->eye, d->eye, sizeof g->eye);
    g->has_depth = own ? d->depth || g->has_clip : d->depth && d->depth->name == g->depth.name &&
                                                       d->clip_depth != GLBK_CLIP_DEPTH_REVERSED;
    return GLBK_OK;
}
