/* ---- csm: building: layers drawn, and compressed to segments for csm.h ---- */

enum {
    GLBK__CSM_ATLAS = 1024,         /* pixels a side at most */
    GLBK__CSM_CHUNK = 65536         /* views after which csm.h's lists begin anew */
};

/* Returns the greatest value of the grid of depths. */
static uint32_t glbk__csm_top(const glbk_csm_builder *b)
{
    return (1u << b->depth_bits) - 1u;
}

/* Makes the atlas of each layer. */
static glbk_result glbk__csm_create_layers(glbk_context *ctx, glbk_csm_builder *b)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result;
    uint32_t i;

    memset(&texture, 0, sizeof texture);
    texture.format = GLBK_FORMAT_DEPTH32F;
    texture.width = texture.height = b->tiles * b->map_side;
    result = glbk_texture_create(ctx, &texture, &b->depth);
    texture.format = GLBK_FORMAT_R32UI;
    for (i = 0; i < b->layer_count && result == GLBK_OK; i++) {
        memset(&target, 0, sizeof target);
        result = glbk_texture_create(ctx, &texture, &b->layers[i]);
        target.color[0] = &b->layers[i];
        target.depth = &b->depth;
        if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &b->layer_targets[i]);
    }
    return result;
}

/* Makes what open segments and records go to: on the core path two textures of open segments, each drawn from
   the other, on the compute path one buffer. */
static glbk_result glbk__csm_create_records(glbk_context *ctx, glbk_csm_builder *b)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result = GLBK_OK;
    size_t pixels = (size_t)b->map_side * b->map_side;
    int i, k;

    if (b->compute) return glbk_buffer_create(ctx, 64 * pixels, NULL, &b->storage);
    memset(&texture, 0, sizeof texture);
    texture.format = GLBK_FORMAT_RGBA32UI;
    texture.width = texture.height = b->map_side;
    for (i = 0; i < 3 && result == GLBK_OK; i++) result = glbk_texture_create(ctx, &texture, &b->records[i]);
    for (i = 0; i < 2 && result == GLBK_OK; i++) {
        memset(&target, 0, sizeof target);
        result = glbk_texture_create(ctx, &texture, &b->opened[i]);
        target.color[0] = &b->opened[i];
        for (k = 0; k < 3; k++) target.color[k + 1] = &b->records[k];
        if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &b->targets[i]);
    }
    return result;
}

/* Begins the open segment of every pixel anew: it may have all values of the grid, and has no view yet. */
static void glbk__csm_open_all(glbk_csm_builder *b)
{
    size_t pixels = (size_t)b->map_side * b->map_side, i;
    memset(b->words, 0, 64 * pixels);
    for (i = 0; i < pixels; i++) {
        b->words[16 * i] = glbk__csm_top(b) << 8 | 65536u;
        b->firsts[i] = b->next_view;
    }
}

/* Uploads the open segments, with the cursor of each at the batch's first view. words has 16 a pixel, of
   which the first 4 are its open segment. */
static glbk_result glbk__csm_write_state(glbk_context *ctx, glbk_csm_builder *b)
{
    const glbk_box whole = { 0, 0, 0, 0, b->map_side, b->map_side, 1 };
    size_t pixels = (size_t)b->map_side * b->map_side, i;
    for (i = 0; i < pixels; i++) b->words[16 * i + 1] = b->words[16 * i + 2] = 0;
    if (b->compute) return glbk_buffer_update(ctx, &b->storage, 0, 64 * pixels, b->words);
    for (i = 1; i < pixels; i++) memmove(b->words + 4 * i, b->words + 16 * i, 16);
    return glbk_texture_update(ctx, &b->opened[b->now], &whole, b->words);
}

/* Reads open segments and records back, 16 words a pixel on either path. */
static glbk_result glbk__csm_read_state(glbk_context *ctx, glbk_csm_builder *b)
{
    uint32_t m = b->map_side, k;
    size_t pixels = (size_t)m * m, i;
    uint32_t *planes = b->words + 16 * pixels;
    glbk_result result = GLBK_OK;

    if (b->compute) return glbk_buffer_read(ctx, &b->storage, 0, 64 * pixels, b->words);
    for (k = 0; k < 4 && result == GLBK_OK; k++) {
        result = glbk_target_read(ctx, &b->targets[b->now], k, 0, 0, m, m, planes);
        for (i = 0; i < pixels && result == GLBK_OK; i++)
            memcpy(b->words + 16 * i + 4 * k, planes + 4 * i, 16);
    }
    return result;
}

/* Keeps a segment of a pixel, which ends before view `end`; returns 0 if there is no memory. */
static int glbk__csm_keep(glbk_context *ctx, glbk_csm_builder *b, uint32_t pixel, uint32_t record,
                          uint32_t end)
{
    cohsm_segment *s;
    if (b->segment_count == b->segment_room) {
        glbk_csm__allocator memory = glbk_csm__memory(ctx);
        size_t room = 2 * b->segment_room + 65536;
        s = (cohsm_segment *)glbk_csm__alloc_array(&memory, room, sizeof *s);
        if (!s) return 0;
        if (b->segment_count) memcpy(s, b->segments, b->segment_count * sizeof *s);
        glbk_csm__free(&memory, b->segments);
        b->segments = s;
        b->segment_room = room;
    }
    s = &b->segments[b->segment_count++];
    s->first = b->firsts[pixel];
    s->pixel = pixel;
    s->value = record & 0x1ffffu;
    b->firsts[pixel] = end;
    return 1;
}

/* Returns whether a domain is of positions, whose views are perspective. */
static int glbk__csm_is_positional(const cohsm_domain *d)
{
    const int directional = d->kind == COHSM_DOMAIN_DEFAULT || d->kind == COHSM_DOMAIN_LATLONG ||
                            d->kind == COHSM_DOMAIN_OCTAHEDRAL;
    if (d->kind == COHSM_DOMAIN_TABLE || d->kind == COHSM_DOMAIN_LIST)
        return d->locations && d->locations[3] != 0;
    return !directional;
}

/* Checks the desc of the maps that a builder is for, and takes over what it needs of it. */
static glbk_result glbk__csm_take_maps(const glbk_context *ctx, const cohsm_desc *d, glbk_csm_builder *out)
{
    static const char function[] = "glbk_csm_builder_create";
    const glbk_result bad = GLBK_ERR_DESC;
    out->map_side = d->map_side ? d->map_side : 128;
    out->depth_bits = d->depth_bits ? d->depth_bits : 8;
    out->open_thickness = d->open_thickness > 0 ? d->open_thickness : 8.0f;
    out->layer_count = d->layers == COHSM_LAYERS_Z1Z3_FAR || d->layers == COHSM_LAYERS_Z1Z3_SPHERE ? 3 : 2;
    out->sphere = d->layers == COHSM_LAYERS_Z1Z3_SPHERE;
    memcpy(out->center, d->center, sizeof out->center);
    out->radius = d->radius;
    out->positional = glbk__csm_is_positional(&d->domain);
    out->self_only = d->self_only;
    if (out->map_side < 4 || out->map_side > 1024)
        return glbk__refuse_range(ctx, bad, function, "desc.maps->map_side", out->map_side, 4, 1024);
    if (out->sphere && !(d->radius > 0 && glbk_csm__finite(d->radius)))
        return glbk__refuse_value(ctx, bad, function, "desc.maps->radius", (double)d->radius,
                                  "above 0 with COHSM_LAYERS_Z1Z3_SPHERE");
    if ((unsigned)d->layers >= COHSM_LAYERS_COUNT)
        return glbk__refuse_value(ctx, bad, function, "desc.maps->layers", (double)d->layers,
                                  "a COHSM_LAYERS_...");
    if (out->depth_bits < 4 || out->depth_bits > 8)
        return glbk__refuse_value(ctx, bad, function, "desc.maps->depth_bits", d->depth_bits, "0 or 4..8");
    if (!(d->open_thickness >= 0) || !glbk_csm__finite(d->open_thickness))
        return glbk__refuse_value(ctx, bad, function, "desc.maps->open_thickness", (double)d->open_thickness,
                                  "0 or more, and finite");
    return GLBK_OK;
}

/* Checks the desc of a builder, and takes over what it says. */
static glbk_result glbk__csm_take_builder(const glbk_context *ctx, const glbk_csm_builder_desc *d,
                                          glbk_csm_builder *out, glbk_attributes *attributes)
{
    static const char function[] = "glbk_csm_builder_create";
    const glbk_result bad = GLBK_ERR_DESC;
    glbk_result result = glbk__require(ctx, function, "desc", d);
    cohsm_desc defaults;

    if (result != GLBK_OK) return result;
    memset(&defaults, 0, sizeof defaults);
    if (!d->view_fn) return glbk__refuse(ctx, bad, function, "desc.view_fn", "is NULL");
    if (!d->draw_fn) return glbk__refuse(ctx, bad, function, "desc.draw_fn", "is NULL");
    out->view_fn = d->view_fn;
    out->draw_fn = d->draw_fn;
    out->user = d->user;
    result = glbk__take_attributes(ctx, function, &d->attributes, attributes);
    if (result == GLBK_OK) result = glbk__csm_take_maps(ctx, d->maps ? d->maps : &defaults, out);
    if (result != GLBK_OK) memset(out, 0, sizeof *out);
    return result;
}

GLBK_DEF glbk_result glbk_csm_builder_create(glbk_context *ctx, const glbk_csm_builder_desc *d,
                                             glbk_csm_builder *out)
{
    glbk_csm__allocator memory;
    glbk_attributes attributes;
    size_t pixels;
    glbk_result result;

    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result == GLBK_OK) result = glbk__csm_take_builder(ctx, d, out, &attributes);
    if (result != GLBK_OK) return result;
    pixels = (size_t)out->map_side * out->map_side;
    out->compute = ctx->compute && 64 * pixels <= ctx->max_storage;
    for (out->tiles = 8; out->tiles * out->map_side > GLBK__CSM_ATLAS; out->tiles /= 2) {}
    out->batch = out->tiles * out->tiles;       /* a power of two: batches end where csm.h's lists do */
    memory = glbk_csm__memory(ctx);
    out->words = (uint32_t *)glbk_csm__alloc_array(&memory, pixels, 80);
    out->firsts = (uint32_t *)glbk_csm__alloc_array(&memory, pixels, 4);
    result = out->words && out->firsts ? GLBK_OK : GLBK_ERR_ALLOC;
    if (result == GLBK_OK)
        result = glbk__drawing_program(ctx, glbk_csm_part(), "csm_peel.frag", &attributes,
                                       "CSM_FIRST=1 GLBK_PLACE", &out->first_layer);
    if (result == GLBK_OK)
        result = glbk__drawing_program(ctx, glbk_csm_part(), "csm_peel.frag", &attributes,
                                       "CSM_FIRST=0 GLBK_PLACE", &out->next_layer);
    if (result == GLBK_OK)
        result = glbk__program_create(ctx, glbk_csm_part(),
                                      out->compute ? "csm_compress.comp" : "csm_compress.frag", NULL,
                                      &out->compress);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_csm_peel), NULL, &out->block);
    if (result == GLBK_OK) result = glbk__csm_create_layers(ctx, out);
    if (result == GLBK_OK) result = glbk__csm_create_records(ctx, out);
    if (result == GLBK_OK) glbk__csm_open_all(out);
    else glbk_csm_builder_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_csm_builder_free(glbk_context *ctx, glbk_csm_builder *b)
{
    int i;
    if (!b) return;
    glbk_program_free(ctx, &b->first_layer);
    glbk_program_free(ctx, &b->next_layer);
    glbk_program_free(ctx, &b->compress);
    for (i = 0; i < 3; i++) {
        glbk_target_free(ctx, &b->layer_targets[i]);
        glbk_texture_free(ctx, &b->layers[i]);
        glbk_texture_free(ctx, &b->records[i]);
    }
    for (i = 0; i < 2; i++) {
        glbk_target_free(ctx, &b->targets[i]);
        glbk_texture_free(ctx, &b->opened[i]);
    }
    glbk_texture_free(ctx, &b->depth);
    glbk_buffer_free(ctx, &b->block);
    glbk_buffer_free(ctx, &b->storage);
    if (ctx) {
        glbk_csm__allocator memory = glbk_csm__memory(ctx);
        glbk_csm__free(&memory, b->words);
        glbk_csm__free(&memory, b->firsts);
        glbk_csm__free(&memory, b->segments);
    }
    memset(b, 0, sizeof *b);
}

/* Fills the uniform block of a batch, all but the camera. */
static void glbk__csm_fill_block(const glbk_csm_builder *b, uint32_t views, glbk_csm_peel *out)
{
    const float m = (float)b->map_side;
    memset(out, 0, sizeof *out);
    out->clip_per_pixel = 2.0f / m;
    out->open_thickness = b->open_thickness * (b->positional ? 2.0f : 65536.0f) / m;
    out->depth_top = glbk__csm_top(b);
    out->side = b->map_side;
    out->tiles_across = b->tiles;
    out->view_count = views;
    out->far_layer = b->layer_count == 3;
    out->positional = b->positional != 0;
    out->self_only = b->self_only != 0;
    out->sphere = b->sphere != 0;
}

/* Notes where a view of positions stands, in radii about the sphere and along the axes of its face, whose
   number is 2 axis, + 1 if it looks along the negative axis; and how deep a radius is. */
static void glbk__csm_note_eye(glbk_csm_builder *b, const cohsm_view *view, uint32_t i)
{
    static const uint8_t next[3] = { 1, 2, 0 };
    uint32_t k, axis = (view->face >> 1) % 3;
    float *e = b->eyes[i];
    for (k = 0; k < 3; k++) {
        axis = next[axis];
        e[k] = (view->location[axis] - b->center[axis]) / b->radius;
    }
    if (view->face & 1) e[2] = -e[2];
    e[3] = b->radius * view->depth_scale;
}

GLBK_DEF glbk_result glbk_csm_builder_draw(glbk_context *ctx, glbk_csm_builder *b, uint32_t from,
                                           uint32_t count)
{
    static const float none[4] = { 1073741824.0f, 0, 0, 0 };    /* the bits of 2.0 as a number */
    glbk_csm_peel block;
    glbk_pass pass;
    cohsm_view view;
    glbk_result result;
    uint32_t layer, i, m;

    result = glbk__require_created(ctx, __func__, "builder", b ? &b->block.name : NULL);
    if (result != GLBK_OK) return result;
    if (!count || count > b->batch)
        return glbk__refuse_range(ctx, count ? GLBK_ERR_LIMIT : GLBK_ERR_ARGUMENT, __func__, "count", count,
                                  1, b->batch);
    m = b->map_side;
    glbk__csm_fill_block(b, count, &block);
    memset(&pass, 0, sizeof pass);
    pass.depth = GLBK_DEPTH_LESS;
    for (layer = 0; layer < b->layer_count; layer++) {
        pass.target = &b->layer_targets[layer];
        for (i = 0; i < count; i++) {
            b->view_fn(b->user, from + i, &view);
            if (b->sphere && b->positional && !layer) glbk__csm_note_eye(b, &view, i);
            memcpy(block.view, view.matrix, sizeof block.view);
            block.depth_scale = view.depth_scale;
            result = glbk__put_block(ctx, GLBK_SLOT_glbk_csm_peel, &b->block, &block);
            if (result != GLBK_OK) return result;
            pass.viewport[0] = (int32_t)(i % b->tiles * m);
            pass.viewport[1] = (int32_t)(i / b->tiles * m);
            pass.viewport[2] = pass.viewport[3] = (int32_t)m;
            result = glbk_begin(ctx, &pass, layer ? &b->next_layer : &b->first_layer);
            if (result != GLBK_OK) return result;
            if (!i) {
                glbk_clear(ctx, pass.target, 0, none);
                glbk_clear_depth(ctx, 1);
            }
            if (layer) glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_layer1, &b->layers[layer - 1]);
            b->draw_fn(b->user, ctx);
        }
    }
    b->drawn = count;
    b->drawn_from = from;
    return GLBK_OK;
}

/* Runs the shader once; it goes on with each pixel until the batch or the room for records ends. */
static glbk_result glbk__csm_run_compress(glbk_context *ctx, glbk_csm_builder *b)
{
    glbk_pass pass;
    glbk_result result;
    uint32_t i, groups = (b->map_side + 7) / 8;

    memset(&pass, 0, sizeof pass);
    pass.target = &b->targets[!b->now];
    if (!b->compute) {
        result = glbk_begin(ctx, &pass, &b->compress);
        if (result != GLBK_OK) return result;
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_opened, &b->opened[b->now]);
    }
    glbk_bind_block(ctx, GLBK_SLOT_glbk_csm_peel, &b->block);
    for (i = 0; i < 3; i++)         /* where there are two layers, the third is not read */
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_layer0 + i, &b->layers[i]);
    b->passes++;
    if (b->compute) {
        glbk_bind_storage(ctx, GLBK_SLOT_glbk_csm_records, &b->storage);
        return glbk_dispatch(ctx, &b->compress, groups, groups, 1);
    }
    glbk_draw_screen(ctx);
    b->now = !b->now;
    return GLBK_OK;
}

/* Keeps the segments that a run has ended. *left receives how many pixels are not through yet. */
static glbk_result glbk__csm_take_records(glbk_context *ctx, glbk_csm_builder *b, size_t *left)
{
    uint32_t pixels = b->map_side * b->map_side, p, i;
    glbk_result result = glbk__csm_read_state(ctx, b);

    *left = 0;
    for (p = 0; p < pixels && result == GLBK_OK; p++) {
        const uint32_t *w = b->words + 16 * (size_t)p;
        for (i = 0; i < w[2] && i < 12; i++)
            if (!glbk__csm_keep(ctx, b, p, w[4 + i], b->next_view + (w[4 + i] >> 17))) return GLBK_ERR_ALLOC;
        *left += w[1] < b->drawn;
    }
    return result;
}

/* Ends all open segments, as lists of csm.h do after 65,536 views. */
static glbk_result glbk__csm_end_all(glbk_context *ctx, glbk_csm_builder *b)
{
    uint32_t pixels = b->map_side * b->map_side, p;
    for (p = 0; p < pixels; p++)
        if (b->firsts[p] != b->next_view &&
            !glbk__csm_keep(ctx, b, p, b->words[16 * (size_t)p] & 0xffffu, b->next_view))
            return GLBK_ERR_ALLOC;
    glbk__csm_open_all(b);
    return GLBK_OK;
}

/* Checks that the views that were drawn last are the next to be compressed. */
static glbk_result glbk__csm_check_batch(const glbk_context *ctx, const glbk_csm_builder *b)
{
    static const char function[] = "glbk_csm_builder_compress";
    const glbk_result bad = GLBK_ERR_ORDER;
    if (!b->drawn)
        return glbk__refuse(ctx, bad, function, "builder", "has drawn no view since the last compression");
    if (b->drawn_from != b->next_view)
        return glbk__refuse_range(ctx, bad, function, "the first view drawn", b->drawn_from, b->next_view,
                                  b->next_view);
    if (b->next_view % GLBK__CSM_CHUNK + b->drawn > GLBK__CSM_CHUNK)
        return glbk__refuse_value(ctx, bad, function, "the end of the views drawn",
                                  (double)b->next_view + b->drawn, "at most the next multiple of 65536");
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_builder_compress(glbk_context *ctx, glbk_csm_builder *b)
{
    glbk_csm_peel block;
    glbk_result result;
    size_t left = 1;

    result = glbk__require_created(ctx, __func__, "builder", b ? &b->block.name : NULL);
    if (result == GLBK_OK) result = glbk__csm_check_batch(ctx, b);
    if (result != GLBK_OK) return result;
    glbk__csm_fill_block(b, b->drawn, &block);
    memcpy(block.eyes, b->eyes, sizeof b->eyes);
    result = glbk_buffer_update(ctx, &b->block, 0, sizeof block, &block);
    if (result == GLBK_OK) result = glbk__csm_write_state(ctx, b);
    while (left && result == GLBK_OK) {
        result = glbk__csm_run_compress(ctx, b);
        if (result == GLBK_OK) result = glbk__csm_take_records(ctx, b, &left);
    }
    if (result != GLBK_OK) return result;
    b->next_view += b->drawn;
    b->drawn = 0;
    return b->next_view % GLBK__CSM_CHUNK == 0 ? glbk__csm_end_all(ctx, b) : GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_builder_end(glbk_context *ctx, glbk_csm_builder *b)
{
    const glbk_result result = glbk__require_created(ctx, __func__, "builder", b ? &b->block.name : NULL);

    if (result != GLBK_OK) return result;
    if (!b->next_view)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "builder", "has compressed no view yet");
    return glbk__csm_end_all(ctx, b);
}
