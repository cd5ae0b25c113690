/* ---- envsh: shadow maps: tiles, casters drawn into them, and cells of their depths ---- */

enum {
    GLBK__ENVSH_RECORD = 8,                 /* texels of a light in the table */
    GLBK__ENVSH_CELL = 8,                   /* texels of the atlas a side of a cell */
    GLBK__ENVSH_MAX_SIDE = 8192,            /* the most texels a side of a page */
    GLBK__ENVSH_FAR = 0x3f800000,           /* the bits of 1, the depth where nothing is */
    GLBK__ENVSH_CLIP_DISTANCE0 = 0x3000,    /* GL's CLIP_DISTANCE0 */
    GLBK__ENVSH_DEPTH_CLAMP = 0x864F,       /* GL's DEPTH_CLAMP */
    GLBK__ENVSH_BASE_LEVEL = 0x813C,        /* GL's TEXTURE_BASE_LEVEL */
    GLBK__ENVSH_MAX_LEVEL = 0x813D          /* GL's TEXTURE_MAX_LEVEL */
};

/* Decides where the tiles lie: as square as they can within the greatest page, then on more pages. No page
   means that not even one tile fits. Cells become as many a side as a power of two needs to cover the
   tile. */
static void glbk__envsh_lay_out(const glbk_context *ctx, glbk_envsh_maps *m)
{
    uint32_t side = ctx->max_side < GLBK__ENVSH_MAX_SIDE ? ctx->max_side : (uint32_t)GLBK__ENVSH_MAX_SIDE;
    uint32_t slots = (m->capacity + m->channel_count - 1) / m->channel_count, most = side / m->map_side;
    for (side = 1; side < most && side * side < slots;) side++;
    m->across = slots < side ? slots : side;
    m->down = (slots + m->across - 1) / m->across;
    m->down = m->down < most ? m->down : most;
    m->page_count = m->down ? (slots + m->across * m->down - 1) / (m->across * m->down) : 0;
    for (m->cells_side = 1, m->levels = 1; m->cells_side * GLBK__ENVSH_CELL < m->map_side; m->levels++)
        m->cells_side *= 2;
}

/* Makes textures and framebuffers of maps whose tiles have their places. */
static glbk_result glbk__envsh_create_textures(glbk_context *ctx, glbk_envsh_maps *m)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result;

    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    texture.format = m->channel_count == 4 ? GLBK_FORMAT_RGBA32UI : GLBK_FORMAT_DEPTH32F;
    texture.width = m->across * m->map_side;
    texture.height = m->down * m->map_side;
    texture.layers = m->page_count;
    result = glbk_texture_create(ctx, &texture, &m->atlas);
    target.depth = &m->atlas;
    if (m->channel_count == 4 && result == GLBK_OK) {
        texture.format = GLBK_FORMAT_DEPTH32F;
        texture.layers = 0;
        result = glbk_texture_create(ctx, &texture, &m->depth);
        target.color[0] = &m->atlas;
        target.depth = &m->depth;
    }
    if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &m->atlas_target);
    texture.format = GLBK_FORMAT_RG32UI;
    texture.width = m->across * m->cells_side;
    texture.height = m->down * m->cells_side;
    texture.layers = m->page_count * m->channel_count;
    texture.levels = m->levels;
    if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &m->cells);
    memset(&target, 0, sizeof target);
    target.color[0] = &m->cells;
    if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &m->cell_target);
    if (result == GLBK_OK)
        result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, GLBK__ENVSH_RECORD * (size_t)m->capacity,
                                   &m->views);
    return result;
}

/* Compiles the programs that draw casters and cells. */
static glbk_result glbk__envsh_create_programs(glbk_context *ctx, const glbk_envsh_maps_desc *d,
                                               glbk_envsh_maps *m)
{
    const char *defines = m->channel_count == 4 ? "ENVSH_RGBA=1 GLBK_PLACE" : "ENVSH_RGBA=0 GLBK_PLACE";
    glbk_attributes attributes;
    glbk_result result = glbk__take_attributes(ctx, "glbk_envsh_maps_create", &d->attributes, &attributes);
    if (result == GLBK_OK)
        result = glbk__drawing_program(ctx, glbk_envsh_part(), "envsh_cast.frag", &attributes, defines,
                                       &m->cast);
    if (result == GLBK_OK)
        result = glbk__program_create(ctx, glbk_envsh_part(), "envsh_cells.frag", defines, &m->make_cells);
    return result;
}

/* Checks a desc and writes what it says, with its defaults. */
static glbk_result glbk__envsh_check_desc(const glbk_context *ctx, const glbk_envsh_maps_desc *d,
                                          glbk_envsh_maps *out)
{
    static const char function[] = "glbk_envsh_maps_create";
    const glbk_result bad = GLBK_ERR_DESC, result = glbk__require(ctx, function, "desc", d);
    if (result != GLBK_OK) return result;
    if (!d->capacity || d->capacity > ENVSH_MAX_LIGHTS)
        return glbk__refuse_range(ctx, bad, function, "desc.capacity", d->capacity, 1, ENVSH_MAX_LIGHTS);
    out->capacity = d->capacity;
    out->map_side = d->maps && d->maps->map_side ? d->maps->map_side : 256;
    out->guard = d->maps && d->maps->guard ? d->maps->guard : 4;
    out->channel_count = d->maps && d->maps->rgba ? 4 : 1;
    if (out->map_side < 16 || out->map_side > 4096)
        return glbk__refuse_range(ctx, bad, function, "desc.maps->map_side", out->map_side, 16, 4096);
    if (out->guard > out->map_side / 4)
        return glbk__refuse_range(ctx, bad, function, "desc.maps->guard", out->guard, 1,
                                  out->map_side / 4);
    return GLBK_OK;
}

/* Gives the tiles their places, and checks that pages with them can be made. */
static glbk_result glbk__envsh_check_pages(const glbk_context *ctx, glbk_envsh_maps *m)
{
    static const char function[] = "glbk_envsh_maps_create";
    const uint32_t most = ctx->max_layers < 1024 ? ctx->max_layers : 1024;
    glbk__envsh_lay_out(ctx, m);
    if (!m->page_count)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "desc.maps->map_side", m->map_side, 16,
                                  ctx->max_side);
    if (m->page_count > most)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "pages for desc.capacity: their number",
                                  m->page_count, 1, most);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_envsh_maps_create(glbk_context *ctx, const glbk_envsh_maps_desc *d,
                                            glbk_envsh_maps *out)
{
    glbk_result result;
    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result != GLBK_OK) return result;
    result = glbk__envsh_check_desc(ctx, d, out);
    if (result == GLBK_OK) result = glbk__envsh_check_pages(ctx, out);
    if (result == GLBK_OK) result = glbk__envsh_create_textures(ctx, out);
    if (result == GLBK_OK) result = glbk__envsh_create_programs(ctx, d, out);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_scene), NULL, &out->scene);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_query), NULL, &out->query);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_envsh_object), NULL, &out->object);
    if (result != GLBK_OK) glbk_envsh_maps_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_envsh_maps_free(glbk_context *ctx, glbk_envsh_maps *m)
{
    if (!m) return;
    glbk_program_free(ctx, &m->cast);
    glbk_program_free(ctx, &m->make_cells);
    glbk_target_free(ctx, &m->atlas_target);
    glbk_target_free(ctx, &m->cell_target);
    glbk_texture_free(ctx, &m->atlas);
    glbk_texture_free(ctx, &m->depth);
    glbk_texture_free(ctx, &m->cells);
    glbk_texture_free(ctx, &m->views);
    glbk_buffer_free(ctx, &m->scene);
    glbk_buffer_free(ctx, &m->query);
    glbk_buffer_free(ctx, &m->object);
    memset(m, 0, sizeof *m);
}

/* Returns whether the first view was made for tiles of this size: its clip space is its texels times
   2 / map_side. A view of zeros fits tiles of any size. */
static int glbk__envsh_views_fit(const glbk_envsh_maps *m, const envsh_view *view)
{
    const float *lookup = view->lookup;
    int c, best = 0;
    for (c = 1; c < 3; c++)
        if (fabsf(lookup[c]) > fabsf(lookup[best])) best = c;
    return fabsf(view->world_to_clip[4 * best] * (float)m->map_side - 2 * lookup[best]) <=
           1e-3f * fabsf(lookup[best]);
}

/* Writes the eight texels of a light, which docs/gpu-layouts.md lists. */
static void glbk__envsh_record(const glbk_envsh_maps *m, const envsh_view *v, uint32_t light, uint32_t *words)
{
    uint32_t slot = light / m->channel_count, place;
    float f[4 * GLBK__ENVSH_RECORD];
    place = slot % m->across | slot / m->across % m->down << 11 | slot / (m->across * m->down) << 22;
    memcpy(f, v->lookup, sizeof v->lookup);
    memcpy(f + 12, v->right, sizeof v->right);
    f[15] = v->texel[0];
    memcpy(f + 16, v->up, sizeof v->up);
    f[19] = v->texel[1];
    memcpy(f + 20, v->direction, sizeof v->direction);
    f[23] = v->depth_range;
    memcpy(f + 24, v->irradiance, sizeof v->irradiance);
    memcpy(f + 27, &place, sizeof place);
    memcpy(f + 28, v->spread, sizeof v->spread);
    memcpy(words, f, sizeof f);
}

/* Sends the lights' table and the block of the scene to the GPU. */
static glbk_result glbk__envsh_upload(glbk_context *ctx, glbk_envsh_maps *m, const envsh_view *views,
                                      uint32_t count)
{
    glbk_envsh__allocator memory = glbk_envsh__memory(ctx);
    uint32_t *words, i;
    glbk_envsh_scene scene;
    glbk_result result = GLBK_OK;

    words = (uint32_t *)glbk_envsh__alloc_array(&memory, (size_t)count + 1, 4 * 4 * GLBK__ENVSH_RECORD);
    if (!words) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i++)
        glbk__envsh_record(m, &views[i], i, words + 4 * GLBK__ENVSH_RECORD * (size_t)i);
    if (count) result = glbk__table_update(ctx, &m->views, 0, GLBK__ENVSH_RECORD * (size_t)count, words);
    glbk_envsh__free(&memory, words);
    if (result != GLBK_OK) return result;
    memset(&scene, 0, sizeof scene);
    scene.map_side = m->map_side;
    scene.guard = m->guard;
    scene.cells_side = m->cells_side;
    scene.level_count = m->levels;
    scene.light_count = m->count = count;
    scene.clip_per_inside = 2.0f / (float)(m->map_side - 2 * m->guard);
    scene.clip_per_texel_x = 2.0f / (float)(m->across * m->map_side);
    scene.clip_per_texel_y = 2.0f / (float)(m->down * m->map_side);
    return glbk_buffer_update(ctx, &m->scene, 0, sizeof scene, &scene);
}

GLBK_DEF glbk_result glbk_envsh_cast(glbk_context *ctx, glbk_envsh_maps *m, const float transform[16])
{
    const glbk_result result = glbk__require_created(ctx, __func__, "maps", m ? &m->object.name : NULL);
    glbk_envsh_object object;
    int i;
    if (result != GLBK_OK) return result;
    memset(&object, 0, sizeof object);
    if (transform) memcpy(object.transform, transform, sizeof object.transform);
    else
        for (i = 0; i < 4; i++) object.transform[5 * i] = 1.0f;
    object.first_light = m->first;
    object.light_step = m->step;
    m->casts++;
    return glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_object, &m->object, &object);
}

/* Turns clip distances 0 to 3 and the clamp of depths on or off. OpenGL needs them while casters are drawn;
   ES has neither. */
static void glbk__envsh_clip(const glbk_context *ctx, int on)
{
    uint32_t i;
    for (i = 0; !ctx->es && i < 4; i++) glbk__set_cap(ctx, GLBK__ENVSH_CLIP_DISTANCE0 + i, on);
    if (!ctx->es) glbk__set_cap(ctx, GLBK__ENVSH_DEPTH_CLAMP, on);
}

/* Who draws the casters, and into which tiles: those of a page and a channel and, on ES, of a column. */
typedef struct glbk__envsh_casting {
    glbk_envsh_draw_fn draw_fn;
    void    *user;
    uint32_t page;
    uint32_t channel;
    uint32_t column;
    int      reversed;              /* not 0: instance 0 draws for the last light, and so on to the first */
} glbk__envsh_casting;

/* Has the user draw all casters once, into the tiles of lights first, first + step, ... */
static glbk_result glbk__envsh_cast_round(glbk_context *ctx, glbk_envsh_maps *m, const glbk__envsh_casting *c)
{
    static const uint32_t far_bits[4] = { GLBK__ENVSH_FAR, GLBK__ENVSH_FAR, GLBK__ENVSH_FAR,
                                          GLBK__ENVSH_FAR };
    const uint32_t tiles = m->across * m->down, column = c->column, channel = c->channel;
    const uint32_t first = (c->page * tiles + column) * m->channel_count + channel;
    const uint32_t step = (ctx->es ? m->across : 1) * m->channel_count;
    const uint32_t after = (c->page + 1) * tiles * m->channel_count;
    const uint32_t end = after < m->count ? after : m->count;
    uint32_t instances, i;
    glbk_pass pass;
    glbk_result result;

    memset(&pass, 0, sizeof pass);
    pass.target = &m->atlas_target;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_begin(ctx, &pass, &m->cast);
    if (result != GLBK_OK) return result;
    i = m->channel_count == 4;
    glbk__attach(ctx, i ? (uint32_t)GLBK_GL_COLOR_ATTACHMENT0 : (uint32_t)GLBK_GL_DEPTH_ATTACHMENT,
                 &m->atlas, 0, c->page);
    if (!column) glbk_clear_depth(ctx, 1);
    if (i && !column && !channel) ctx->gl.ClearBufferuiv(GLBK_GL_COLOR, 0, far_bits);
    if (first >= end) return GLBK_OK;
    if (i) ctx->gl.ColorMask(channel == 0, channel == 1, channel == 2, channel == 3);
    if (ctx->es)
        ctx->gl.Viewport((int32_t)(column * m->map_side + m->guard), 0, (int32_t)(m->map_side - 2 * m->guard),
                         (int32_t)m->atlas_target.height);
    glbk__envsh_clip(ctx, 1);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_views, &m->views);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_envsh_scene, &m->scene);
    instances = (end - first + step - 1) / step;
    m->first = c->reversed ? first + (instances - 1) * step : first;
    m->step = c->reversed ? 0 - step : step;        /* shaders multiply it modulo 2^32 */
    m->casts = 0;
    result = c->draw_fn(c->user, ctx, m, instances);
    if (!ctx->lost) glbk__envsh_clip(ctx, 0);
    if (ctx->check && result == GLBK_OK && !m->casts)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, "glbk_envsh_maps_render", "draw_fn",
                            "never called glbk_envsh_cast");
    return result;
}

/* Draws all levels of cells of a layer. Each reads the level below, which is the texture's only one
   meanwhile, since a level must not be read while it is drawn. */
static glbk_result glbk__envsh_cell_layer(glbk_context *ctx, glbk_envsh_maps *m, uint32_t layer)
{
    glbk_envsh_object object;
    glbk_pass pass;
    glbk_result result = GLBK_OK;
    uint32_t level;

    memset(&object, 0, sizeof object);
    memset(&pass, 0, sizeof pass);
    pass.target = &m->cell_target;
    object.layer = layer;
    for (level = 0; level < m->levels && result == GLBK_OK; level++) {
        const int32_t below = level ? (int32_t)level - 1 : 0;
        object.level = level;
        pass.viewport[2] = (int32_t)(m->cells.width >> level);
        pass.viewport[3] = (int32_t)(m->cells.height >> level);
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_envsh_object, &m->object, &object);
        if (result == GLBK_OK) result = glbk_begin(ctx, &pass, &m->make_cells);
        if (result != GLBK_OK) break;
        glbk__attach(ctx, GLBK_GL_COLOR_ATTACHMENT0, &m->cells, level, layer);
        glbk_bind_texture(ctx,
                          m->channel_count == 4 ? GLBK_SLOT_glbk_envsh_depth4 : GLBK_SLOT_glbk_envsh_depth,
                          &m->atlas);
        glbk_bind_block(ctx, GLBK_SLOT_glbk_envsh_scene, &m->scene);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_cells, &m->cells);
        ctx->gl.TexParameteri(m->cells.gl_target, GLBK__ENVSH_BASE_LEVEL, below);
        ctx->gl.TexParameteri(m->cells.gl_target, GLBK__ENVSH_MAX_LEVEL, below);
        if (!level) glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_cells, NULL);  /* it reads none */
        glbk_draw_screen(ctx);
    }
    if (ctx->lost) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_envsh_cells, &m->cells);
    ctx->gl.TexParameteri(m->cells.gl_target, GLBK__ENVSH_BASE_LEVEL, 0);
    ctx->gl.TexParameteri(m->cells.gl_target, GLBK__ENVSH_MAX_LEVEL, (int32_t)m->levels - 1);
    return result;
}

/* Returns how many pages the maps of the frame fill, at least in part. */
static uint32_t glbk__envsh_page_count(const glbk_envsh_maps *m)
{
    const uint32_t page = m->across * m->down * m->channel_count;
    return (m->count + page - 1) / page;
}

/* Draws all maps and their cells. */
static glbk_result glbk__envsh_draw_all(glbk_context *ctx, glbk_envsh_maps *m, glbk__envsh_casting *c)
{
    const uint32_t pages = glbk__envsh_page_count(m), columns = ctx->es ? m->across : 1;
    glbk_result result = GLBK_OK;
    uint32_t layer;

    for (c->page = 0; c->page < pages; c->page++)
        for (c->channel = 0; c->channel < m->channel_count; c->channel++)
            for (c->column = 0; c->column < columns && result == GLBK_OK; c->column++)
                result = glbk__envsh_cast_round(ctx, m, c);
    for (layer = 0; layer < pages * m->channel_count && result == GLBK_OK; layer++)
        result = glbk__envsh_cell_layer(ctx, m, layer);
    return result;
}

/* Writes for each layer a number that all its cells of the finest level determine. */
static glbk_result glbk__envsh_digest_cells(glbk_context *ctx, glbk_envsh_maps *m, uint64_t *digests)
{
    const uint32_t layers = glbk__envsh_page_count(m) * m->channel_count;
    const uint32_t wide = m->cells.width, high = m->cells.height;
    const glbk_envsh__allocator memory = glbk_envsh__memory(ctx);
    uint32_t *cells = (uint32_t *)glbk_envsh__alloc_array(&memory, (size_t)wide * high, 16), layer;
    glbk_result result = cells ? GLBK_OK : GLBK_ERR_ALLOC;
    glbk_pass pass;
    size_t i;

    memset(&pass, 0, sizeof pass);
    pass.target = &m->cell_target;
    for (layer = 0; layer < layers && result == GLBK_OK; layer++) {
        result = glbk_begin(ctx, &pass, &m->make_cells);
        if (result != GLBK_OK) break;
        glbk__attach(ctx, GLBK_GL_COLOR_ATTACHMENT0, &m->cells, 0, layer);
        result = glbk_target_read(ctx, &m->cell_target, 0, 0, 0, wide, high, cells);
        digests[layer] = 1;
        for (i = 0; i < 4 * (size_t)wide * high && result == GLBK_OK; i++)
            digests[layer] = (digests[layer] ^ cells[i]) * 0x9e3779b97f4a7c15u;
    }
    glbk_envsh__free(&memory, cells);
    return result;
}

/* Finds out whether draw_fn drew all instances, with desc.check of the context: draws the maps once more,
   with the instances in the opposite order. If each instance of each caster is drawn, the maps are the same
   again. If only the first ones are, other lights get them now. */
static glbk_result glbk__envsh_check_instances(glbk_context *ctx, glbk_envsh_maps *m, glbk__envsh_casting *c)
{
    const uint32_t layers = glbk__envsh_page_count(m) * m->channel_count;
    const glbk_envsh__allocator memory = glbk_envsh__memory(ctx);
    uint64_t *digests = (uint64_t *)glbk_envsh__alloc_array(&memory, (size_t)layers + 1, 2 * sizeof *digests);
    glbk_result result = digests ? GLBK_OK : GLBK_ERR_ALLOC;

    if (result == GLBK_OK) result = glbk__envsh_digest_cells(ctx, m, digests);
    c->reversed = 1;
    if (result == GLBK_OK) result = glbk__envsh_draw_all(ctx, m, c);
    if (result == GLBK_OK) result = glbk__envsh_digest_cells(ctx, m, digests + layers);
    if (result == GLBK_OK && memcmp(digests, digests + layers, layers * sizeof *digests) != 0)
        result = glbk__refuse(ctx, GLBK_ERR_ORDER, "glbk_envsh_maps_render", "draw_fn",
                              "drew fewer instances of a caster than it was given");
    glbk_envsh__free(&memory, digests);
    return result;
}

GLBK_DEF glbk_result glbk_envsh_maps_render(glbk_context *ctx, glbk_envsh_maps *m, const envsh_view *views,
                                            uint32_t count, glbk_envsh_draw_fn draw_fn, void *user)
{
    glbk_result result = glbk__require_created(ctx, __func__, "maps", m ? &m->views.name : NULL);
    glbk__envsh_casting casting;

    if (result == GLBK_OK && count) result = glbk__require(ctx, __func__, "views", views);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "draw_fn", draw_fn ? m : NULL);
    if (result != GLBK_OK) return result;
    if (count > m->capacity)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, __func__, "count", count, 0, m->capacity);
    if (count && !glbk__envsh_views_fit(m, views))
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, __func__, "maps->map_side", m->map_side,
                                  "the map_side of the envsh_maps_desc that made the views");
    if (count && views->guard && views->guard != m->guard)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, __func__, "maps->guard", m->guard,
                                  "the guard of the envsh_maps_desc that made the views");
    m->count = 0;
    memset(&casting, 0, sizeof casting);
    casting.draw_fn = draw_fn;
    casting.user = user;
    result = glbk__envsh_upload(ctx, m, views, count);
    if (result == GLBK_OK) result = glbk__envsh_draw_all(ctx, m, &casting);
    if (result == GLBK_OK && ctx->check) result = glbk__envsh_check_instances(ctx, m, &casting);
    if (result != GLBK_OK) m->count = 0;
    return result;
}
