/* ---- rsm: maps from textures of the user's own ---- */

/* Bits of the block's `given`, as rsm_import.frag has them. */
enum {
    GLBK__RSM_HAS_DEPTH = 1, GLBK__RSM_HAS_PLACES = 2, GLBK__RSM_HAS_COLORS = 4, GLBK__RSM_HAS_MATERIALS = 8,
    GLBK__RSM_IS_REVERSED = 16, GLBK__RSM_IS_FLUX = 32
};

enum { GLBK__RSM_LAYERS = 5 };      /* textures of an import */

/* Lists the textures of an import, in the order of their slots. */
static void glbk__rsm_import_layers(const glbk_rsm_import *d, const glbk_rsm_layer *layers[GLBK__RSM_LAYERS])
{
    layers[0] = &d->depth;
    layers[1] = &d->positions;
    layers[2] = &d->normals;
    layers[3] = &d->colors;
    layers[4] = &d->materials;
}

/* Returns of which kind a texture is: 0 2D, 1 an array, 2 a cube, as KIND of rsm_import.frag. */
static int glbk__rsm_import_kind(const glbk_texture *t)
{
    if (t->gl_target == GLBK_GL_TEXTURE_CUBE_MAP) return 2;
    return t->layers ? 1 : 0;
}

/* Checks that a texture of an import has the face that is imported. */
static glbk_result glbk__rsm_import_size_check(const glbk_context *ctx, const glbk_rsm_map *map,
                                               const glbk_rsm_import *d, const char *name,
                                               const glbk_texture *t)
{
    static const char function[] = "glbk_rsm_map_import";
    const glbk_result bad = GLBK_ERR_MISMATCH;
    if (glbk__rsm_import_kind(t) == 2) {
        if (t->width == map->side && t->height == map->side) return GLBK_OK;
        return glbk__refuse(ctx, bad, function, name, "is a cube that has not the side of the map");
    }
    if (t->width < map->side || t->width - map->side < d->left)
        return glbk__refuse(ctx, bad, function, name, "is not as wide as import.left and the map's side");
    if (t->height < map->side || t->height - map->side < d->bottom)
        return glbk__refuse(ctx, bad, function, name, "is not as high as import.bottom and the map's side");
    return GLBK_OK;
}

/* Checks the textures of an import, and finds their kind. */
static glbk_result glbk__rsm_import_textures_check(const glbk_context *ctx, const glbk_rsm_map *map,
                                                   const glbk_rsm_import *d, int *kind)
{
    static const char function[] = "glbk_rsm_map_import";
    static const char *const names[GLBK__RSM_LAYERS] = { "import.depth", "import.positions", "import.normals",
                                                         "import.colors", "import.materials" };
    const glbk_rsm_layer *layers[GLBK__RSM_LAYERS];
    const glbk_result bad = GLBK_ERR_DESC;
    int i;
    glbk__rsm_import_layers(d, layers);
    *kind = d->normals.texture ? glbk__rsm_import_kind(d->normals.texture) : 0;
    for (i = 0; i < GLBK__RSM_LAYERS; i++) {
        const glbk_texture *t = layers[i]->texture;
        glbk_result result;
        if (!t) continue;
        if (!t->name) return glbk__refuse(ctx, bad, function, names[i], "has no name of GL");
        if (glbk__rsm_import_kind(t) != *kind)
            return glbk__refuse(ctx, bad, function, names[i],
                                "and import.normals are not of one kind: 2D, arrays or cubes");
        if (*kind == 2 && map->light.kind == RSM_LIGHT_SUN)
            return glbk__refuse(ctx, bad, function, names[i], "is a cube, and the light is a sun");
        if (layers[i]->layer >= (*kind == 1 ? t->layers : 1u))
            return glbk__refuse_element_value(ctx, bad, function, names[i], GLBK__NO_INDEX, ".layer",
                                              layers[i]->layer, "below the layers of the texture");
        result = glbk__rsm_import_size_check(ctx, map, d, names[i], t);
        if (result != GLBK_OK) return result;
    }
    return GLBK_OK;
}

/* Checks that an import can be done, and finds the kind of its textures. */
static glbk_result glbk__rsm_import_check(const glbk_context *ctx, const glbk_rsm_map *map,
                                          const glbk_rsm_import *d, int *kind)
{
    static const char function[] = "glbk_rsm_map_import";
    const glbk__rsm_range fields[] = {
        { "import.clip_depth", (double)d->clip_depth, 0, GLBK_CLIP_DEPTH_COUNT - 1 },
        { "import.normal_packing", (double)d->normal_packing, 0, GLBK_NORMAL_PACKING_COUNT - 1 },
        { "import.color_kind", (double)d->color_kind, 0, GLBK_RSM_COLOR_COUNT - 1 },
        { "import.color[0]", (double)d->color[0], 0, 1e12 },
        { "import.color[1]", (double)d->color[1], 0, 1e12 },
        { "import.color[2]", (double)d->color[2], 0, 1e12 }
    };
    glbk_result result;
    if (!d->normals.texture) return glbk__refuse(ctx, GLBK_ERR_DESC, function, "import.normals", "is NULL");
    if (!d->depth.texture && !d->positions.texture)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "import.depth",
                            "and import.positions are NULL; one is needed");
    result = glbk__rsm_in_range(ctx, function, fields, sizeof fields / sizeof fields[0]);
    return result == GLBK_OK ? glbk__rsm_import_textures_check(ctx, map, d, kind) : result;
}

/* Returns what there is, as bits. */
static uint32_t glbk__rsm_import_given(const glbk_rsm_import *d)
{
    uint32_t bits = 0;
    if (d->depth.texture) bits |= GLBK__RSM_HAS_DEPTH;
    if (d->positions.texture) bits |= GLBK__RSM_HAS_PLACES;
    if (d->colors.texture) bits |= GLBK__RSM_HAS_COLORS;
    if (d->materials.texture) bits |= GLBK__RSM_HAS_MATERIALS;
    if (d->clip_depth == GLBK_CLIP_DEPTH_REVERSED) bits |= GLBK__RSM_IS_REVERSED;
    if (d->color_kind == GLBK_RSM_COLOR_FLUX) bits |= GLBK__RSM_IS_FLUX;
    return bits;
}

/* Fills the block of an import. */
static void glbk__rsm_fill_import(const glbk_rsm_map *map, uint32_t face, const glbk_rsm_import *d,
                                  glbk_rsm_imported *out)
{
    int i, any = 0;
    memset(out, 0, sizeof *out);
    for (i = 0; i < 16; i++) any = any || fabsf(d->to_world[i]) > 0.0f;
    memcpy(out->to_world, d->to_world, sizeof d->to_world);
    for (i = 0; i < 16 && !any; i += 5) out->to_world[i] = 1.0f;
    for (i = 0, any = 0; i < 3; i++) any = any || d->color[i] > 0.0f;
    for (i = 0; i < 3; i++) out->color[i] = any ? d->color[i] : 1.0f;
    out->near_depth = map->light.near_depth;
    out->far_depth = map->light.far_depth;
    out->face = face;
    out->given = glbk__rsm_import_given(d);
    out->normal_packing = (uint32_t)d->normal_packing;
    out->material = d->material;
    out->left = d->left;
    out->bottom = d->bottom;
    out->depth_layer = d->depth.layer;
    out->place_layer = d->positions.layer;
    out->normal_layer = d->normals.layer;
    out->color_layer = d->colors.layer;
    out->material_layer = d->materials.layer;
}

/* Binds the textures of an import, whose glbk_texture need not have gl_target; bound == 0: takes cubes away
   again, since glbk_state_restore knows nothing of such bindings. */
static void glbk__rsm_bind_import(glbk_context *ctx, const glbk_rsm_import *d, int kind, int bound)
{
    static const uint32_t targets[3] = { GLBK_GL_TEXTURE_2D, GLBK_GL_TEXTURE_2D_ARRAY,
                                         GLBK_GL_TEXTURE_CUBE_MAP };
    static const uint32_t slots[GLBK__RSM_LAYERS] = { GLBK_SLOT_glbk_rsm_depth_in,
                                                      GLBK_SLOT_glbk_rsm_place_in,
                                                      GLBK_SLOT_glbk_rsm_normal_in,
                                                      GLBK_SLOT_glbk_rsm_color_in,
                                                      GLBK_SLOT_glbk_rsm_material_in };
    const glbk_rsm_layer *layers[GLBK__RSM_LAYERS];
    int i;
    glbk__rsm_import_layers(d, layers);
    for (i = 0; i < GLBK__RSM_LAYERS; i++) {
        glbk_texture t;
        memset(&t, 0, sizeof t);
        if (bound && layers[i]->texture) t = *layers[i]->texture;
        t.gl_target = targets[kind];
        glbk_bind_texture(ctx, slots[i], &t);
        if (!bound) ctx->gl.BindTexture(GLBK_GL_TEXTURE_CUBE_MAP, 0);
    }
}

GLBK_DEF glbk_result glbk_rsm_map_import(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map,
                                         uint32_t face, const glbk_rsm_import *import)
{
    glbk_rsm_imported block;
    glbk_pass pass;
    glbk_result result;
    int kind = 0, which;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_renderer_check(ctx, __func__, r);
    if (result == GLBK_OK) result = glbk__rsm_map_check(ctx, __func__, map);
    if (result != GLBK_OK) return result;
    if (face >= map->face_count)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "face", face, 0, map->face_count - 1.0);
    if (!import) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "import", "is NULL");
    result = glbk__rsm_import_check(ctx, map, import, &kind);
    if (result != GLBK_OK) return result;
    which = GLBK__RSM_IMPORT + kind;
    glbk__rsm_fill_import(map, face, import, &block);
    result = glbk__rsm_program(ctx, r, which);
    if (result == GLBK_OK)
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_rsm_imported, &r->imported, &block);
    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    pass.target = &map->face_targets[face];
    result = glbk_begin(ctx, &pass, &r->programs[which]);
    if (result != GLBK_OK) return result;
    map->summed = 0;
    glbk_bind_block(ctx, GLBK_SLOT_glbk_rsm_light, &map->buffer);
    glbk__rsm_bind_import(ctx, import, kind, 1);
    glbk_draw_screen(ctx);
    if (kind == 2) glbk__rsm_bind_import(ctx, import, kind, 0);
    return ctx->lost ? GLBK_ERR_LOST : glbk__leave_frame(ctx);
}
