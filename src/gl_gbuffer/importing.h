/* ---- gbuffer: from textures of the user's own ---- */

enum {
    GLBK__IMPORT_PLACES = 1, GLBK__IMPORT_DEPTH = 2, GLBK__IMPORT_FLAT = 4, GLBK__IMPORT_COLORS = 8,
    GLBK__IMPORT_GLOSS = 16, GLBK__IMPORT_OPEN = 32, GLBK__IMPORT_ENTITIES = 64, GLBK__IMPORT_REVERSED = 128
};

/* The inverse of a matrix by elimination with pivots, or 0. */
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

/* One texture of the user's: there or not, of the right size and kind. */
static int glbk__gbuffer_takes(const glbk_context *ctx, const glbk_gbuffer *g, const char *field, const glbk_texture *t)
{
    const char *text = NULL;
    if (!t) return 1;
    if (!t->name || t->layers) text = "is no 2D texture";
    else if (t->width != g->width || t->height != g->height) text = "is of another size";
    if (text) glbk__gbuffer_bad(ctx, "glbk_gbuffer_import", field, text);
    return !text;
}

static int glbk__gbuffer_import_valid(const glbk_context *ctx, const glbk_gbuffer *g, const glbk_import *d)
{
    const char *const function = "glbk_gbuffer_import";
    if (!d->normals || (!d->depth && !d->positions)) {
        glbk__gbuffer_bad(ctx, function, "import", "needs normals, and depth or positions");
        return 0;
    }
    if (d->depth && !d->positions && glbk__gbuffer_is_zero(d->world_to_clip, 16)) {
        glbk__gbuffer_bad(ctx, function, "import.world_to_clip", "is needed for places by their depths");
        return 0;
    }
    return glbk__gbuffer_takes(ctx, g, "import.depth", d->depth) &&
           glbk__gbuffer_takes(ctx, g, "import.positions", d->positions) &&
           glbk__gbuffer_takes(ctx, g, "import.normals", d->normals) &&
           glbk__gbuffer_takes(ctx, g, "import.geometric", d->geometric) &&
           glbk__gbuffer_takes(ctx, g, "import.color_map", d->color_map) &&
           glbk__gbuffer_takes(ctx, g, "import.gloss_map", d->gloss_map) &&
           glbk__gbuffer_takes(ctx, g, "import.open_map", d->open_map) &&
           glbk__gbuffer_takes(ctx, g, "import.entities", d->entities) &&
           glbk__gbuffer_within(ctx, function, "import.clip_depth", d->clip_depth, 0, GLBK_CLIP_DEPTH_COUNT - 1) &&
           glbk__gbuffer_within(ctx, function, "import.normal_packing", d->normal_packing, 0,
                                GLBK_NORMAL_PACKING_COUNT - 1) &&
           glbk__gbuffer_material_valid(ctx, function, &d->material, d->plane, d->occlusion);
}

/* World to clip space in OpenGL's convention. */
static void glbk__gbuffer_clip(const glbk_import *d, float clip[16])
{
    const int reversed = d->clip_depth == GLBK_CLIP_DEPTH_REVERSED;
    int c;
    memcpy(clip, d->world_to_clip, sizeof d->world_to_clip);
    if (!reversed && d->clip_depth != GLBK_CLIP_DEPTH_ZERO_TO_ONE) return;
    for (c = 0; c < 4; c++)
        clip[4 * c + 2] = reversed ? clip[4 * c + 3] - 2 * clip[4 * c + 2] : 2 * clip[4 * c + 2] - clip[4 * c + 3];
}

static void glbk__gbuffer_fill_import(const glbk_gbuffer *g, const glbk_import *d, glbk_gbuffer_imported *v)
{
    const int reversed = d->clip_depth == GLBK_CLIP_DEPTH_REVERSED;
    const int half = !reversed && d->clip_depth != GLBK_CLIP_DEPTH_ZERO_TO_ONE;
    uint32_t *how = v->how;

    glbk__gbuffer_clip(d, v->to_clip);
    glbk__gbuffer_matrix(d->to_world, v->to_world);
    v->numbers[0] = glbk__gbuffer_kind(&d->material);
    v->numbers[1] = d->entity;
    v->numbers[2] = d->plane;
    v->lobes[0] = d->first_lobe;
    v->lobes[1] = d->material.lobe_count;
    how[0] = (d->positions ? (uint32_t)GLBK__IMPORT_PLACES : 0u) | (d->depth ? (uint32_t)GLBK__IMPORT_DEPTH : 0u) |
             (d->geometric ? (uint32_t)GLBK__IMPORT_FLAT : 0u) | (d->color_map ? (uint32_t)GLBK__IMPORT_COLORS : 0u) |
             (d->gloss_map ? (uint32_t)GLBK__IMPORT_GLOSS : 0u) | (d->open_map ? (uint32_t)GLBK__IMPORT_OPEN : 0u) |
             (d->entities ? (uint32_t)GLBK__IMPORT_ENTITIES : 0u) | (reversed ? (uint32_t)GLBK__IMPORT_REVERSED : 0u);
    how[1] = (uint32_t)d->normal_packing;
    how[2] = g->width;
    how[3] = g->height;
    memcpy(v->diffuse, d->material.diffuse, sizeof d->material.diffuse);
    glbk__gbuffer_gloss(&d->material, v->gloss);
    memcpy(v->eye, d->eye, sizeof d->eye);
    v->depths[0] = half ? 2.0f : 1.0f;
    v->depths[1] = half ? -1.0f : 0.0f;
    v->depths[2] = d->occlusion;
}

/* Texture objects that were not made here have no gl_target. */
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
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_flat_in, d->geometric);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_open_in, d->open_map);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_entity_in, d->entities);
}

GLBK_DEF glbk_result glbk_gbuffer_import(glbk_context *ctx, glbk_gbuffer *g, const glbk_import *d)
{
    glbk_gbuffer_imported values;
    glbk_result result = GLBK_OK;
    int own;

    if (!ctx || !g || !g->target.name || !d)
        return glbk__bad(ctx, GLBK_ERR_ARGUMENT, __func__, "gbuffer or import", "is NULL or was not created");
    if (!glbk__gbuffer_import_valid(ctx, g, d)) return GLBK_ERR_DESC;
    own = g->own_depth;
    memset(&values, 0, sizeof values);
    g->has_clip = !glbk__gbuffer_is_zero(d->world_to_clip, 16);
    if (g->has_clip && !glbk__gbuffer_invert(d->world_to_clip, values.from_clip))
        return glbk__gbuffer_bad(ctx, __func__, "import.world_to_clip", "has no inverse");
    glbk__gbuffer_fill_import(g, d, &values);
    if (!g->take.name)
        result = glbk_program_create(ctx, glbk_gbuffer_part(), "gbuffer_import.frag",
                                     own ? "GBUFFER_DEPTH=1" : "GBUFFER_DEPTH=0", &g->take);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_gbuffer_imported, &g->imported, &values);
    if (result == GLBK_OK)
        result = glbk__gbuffer_start(ctx, own ? &g->target : &g->colors, own ? GLBK_DEPTH_LESS : GLBK_DEPTH_OFF,
                                     &g->take);
    if (result != GLBK_OK) return result;
    glbk__gbuffer_bind_import(ctx, d);
    glbk_draw_screen(ctx);
    memcpy(g->clip, values.to_clip, sizeof g->clip);
    memcpy(g->eye, d->eye, sizeof g->eye);
    g->has_depth = own ? d->depth || g->has_clip : d->depth && d->depth->name == g->depth.name &&
                                                       d->clip_depth != GLBK_CLIP_DEPTH_REVERSED;
    return GLBK_OK;
}
