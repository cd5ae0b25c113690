/* ---- rsm: maps: their images, uploads and readings ---- */

enum {                              /* programs of a renderer */
    GLBK__RSM_FILL,
    GLBK__RSM_SCAN,                 /* the first step of sums along rows; _ON does the next steps */
    GLBK__RSM_SCAN_ON,
    GLBK__RSM_SCAN_ROWS,            /* the first step of sums of rows */
    GLBK__RSM_SCAN_ROWS_ON,
    GLBK__RSM_PICK,
    GLBK__RSM_PICK_ALL,
    GLBK__RSM_IMPORT,               /* from 2D textures; the next two from arrays and from cubes */
    GLBK__RSM_IMPORT_ARRAYS,
    GLBK__RSM_IMPORT_CUBES,
    GLBK__RSM_STATS,
    GLBK__RSM_DIRECT,               /* from here on all but DO_SCAN and DO_SCAN_ROWS read the G-buffer */
    GLBK__RSM_GATHER,
    GLBK__RSM_INTERPOLATE,
    GLBK__RSM_RECALL,
    GLBK__RSM_SMOOTH,
    GLBK__RSM_RESOLVE,
    GLBK__RSM_DO_SCAN,              /* a compute shader, like all that follow but GATHER_SURFACES */
    GLBK__RSM_DO_SCAN_ROWS,
    GLBK__RSM_DO_GATHER,
    GLBK__RSM_DO_NODES,
    GLBK__RSM_GATHER_SURFACES,      /* for near_field, like the next two */
    GLBK__RSM_DO_GATHER_SURFACES,
    GLBK__RSM_DO_NODES_SURFACES,
    GLBK__RSM_DO_BEGIN,
    GLBK__RSM_DO_INTERPOLATE,
    GLBK__RSM_DO_LISTED,
    GLBK__RSM_DO_SMOOTH
};

/* Each program has its file and its defines here. */
static const char *const glbk__rsm_programs[GLBK_RSM_PROGRAM_COUNT][2] = {
    { "rsm_fill.frag", NULL },
    { "rsm_scan.frag", "FROM=0" },
    { "rsm_scan.frag", "FROM=1" },
    { "rsm_scan.frag", "FROM=2" },
    { "rsm_scan.frag", "FROM=3" },
    { "rsm_pick.frag", "ALL=0" },
    { "rsm_pick.frag", "ALL=1" },
    { "rsm_import.frag", "KIND=0" },
    { "rsm_import.frag", "KIND=1" },
    { "rsm_import.frag", "KIND=2" },
    { "rsm_stats.frag", NULL },
    { "rsm_direct.frag", NULL },
    { "rsm_gather.frag", NULL },
    { "rsm_interpolate.frag", NULL },
    { "rsm_recall.frag", NULL },
    { "rsm_smooth.frag", NULL },
    { "rsm_resolve.frag", NULL },
    { "rsm_scan.comp", "ROWS=0" },
    { "rsm_scan.comp", "ROWS=1" },
    { "rsm_gather.comp", "NODES=0" },
    { "rsm_gather.comp", "NODES=1" },
    { "rsm_gather.frag", "RSM_SURFACES=1" },
    { "rsm_gather.comp", "NODES=0 RSM_SURFACES=1" },
    { "rsm_gather.comp", "NODES=1 RSM_SURFACES=1" },
    { "rsm_begin.comp", NULL },
    { "rsm_interpolate.comp", "RSM_GROUP=256" },
    { "rsm_interpolate.comp", "RSM_GROUP=64" },
    { "rsm_smooth.comp", NULL }
};

/* Returns how many faces the map of a light has. */
static uint32_t glbk__rsm_face_count(const rsm_light *l)
{
    if (l->kind == RSM_LIGHT_PATCH) return 5;
    return l->kind == RSM_LIGHT_POINT || (l->kind == RSM_LIGHT_SPOT && l->cone_half_angle > 1.0f) ? 6 : 1;
}

/* Writes a vector, and w as the fourth number. */
static void glbk__rsm_set4(float *out, glbk_rsm__v3 v, float w)
{
    glbk_rsm__v3_store(out, v);
    out[3] = w;
}

/* Fills the block that shaders know the light by, as rsm.h computes its numbers. */
static void glbk__rsm_set_block(glbk_rsm_map *map)
{
    const rsm_light *l = &map->light;
    glbk_rsm__v3 axis = glbk_rsm__v3_make(0, 0, -1), up = glbk_rsm__v3_make(0, 1, 0), right;
    float extent = 1.0f, cos_half = -1.0f;
    if (l->kind != RSM_LIGHT_POINT) {
        axis = glbk_rsm__v3_normalize(glbk_rsm__v3_load(l->direction));
        if (l->kind == RSM_LIGHT_SUN) axis = glbk_rsm__v3_scale(axis, -1);
        up = glbk_rsm__v3_normalize(glbk_rsm__v3_load(l->up));
    }
    if (glbk_rsm__v3_length(glbk_rsm__v3_cross(axis, up)) < 1e-3f)
        up = fabsf(axis.y) < 0.9f ? glbk_rsm__v3_make(0, 1, 0) : glbk_rsm__v3_make(0, 0, 1);
    right = glbk_rsm__v3_normalize(glbk_rsm__v3_cross(axis, up));
    up = glbk_rsm__v3_cross(right, axis);
    if (l->kind == RSM_LIGHT_SUN) extent = l->radius;
    if ((l->kind == RSM_LIGHT_SPOT && map->face_count == 1) || l->kind == RSM_LIGHT_SQUARE_SPOT)
        extent = tanf(l->cone_half_angle);
    if (l->kind == RSM_LIGHT_SPOT) cos_half = cosf(l->cone_half_angle);
    glbk__rsm_set4(map->block.position, glbk_rsm__v3_load(l->position), 1);
    glbk__rsm_set4(map->block.right, right, 0);
    glbk__rsm_set4(map->block.up, up, 0);
    glbk__rsm_set4(map->block.axis, axis, 0);
    glbk__rsm_set4(map->block.value, glbk_rsm__v3_load(l->value), 0);
    map->block.extent = extent;
    map->block.cos_half = cos_half;
    map->block.side = map->side;
    map->block.face_count = map->face_count;
    map->block.kind = (uint32_t)l->kind;
}

/* Finds right, up and axis of a face, as rsm.h does. */
static void glbk__rsm_face_axes(const glbk_rsm_map *map, uint32_t face, glbk_rsm__v3 *r, glbk_rsm__v3 *u,
                                glbk_rsm__v3 *a)
{
    glbk_rsm__v3 right = glbk_rsm__v3_load(map->block.right), up = glbk_rsm__v3_load(map->block.up);
    glbk_rsm__v3 axis = glbk_rsm__v3_load(map->block.axis);
    *r = right;
    *u = up;
    *a = axis;
    switch (face) {
    case 1: *r = glbk_rsm__v3_scale(axis, -1); *a = right; break;
    case 2: *r = axis; *a = glbk_rsm__v3_scale(right, -1); break;
    case 3: *u = glbk_rsm__v3_scale(axis, -1); *a = up; break;
    case 4: *u = axis; *a = glbk_rsm__v3_scale(up, -1); break;
    case 5: *r = glbk_rsm__v3_scale(right, -1); *a = glbk_rsm__v3_scale(axis, -1); break;
    default: break;
    }
}

/* Computes the matrix that a face is drawn with, world to OpenGL's clip space. */
static void glbk__rsm_face_matrix(const glbk_rsm_map *map, uint32_t face, float m[16])
{
    glbk_rsm__v3 r, u, a, p;
    const int perspective = map->light.kind != RSM_LIGHT_SUN;
    const float n = map->light.near_depth, f = map->light.far_depth, s = 1.0f / map->block.extent;
    const float z0 = perspective ? (f + n) / (f - n) : 2.0f / (f - n);
    const float z1 = perspective ? -2.0f * n * f / (f - n) : -2.0f * n / (f - n) - 1.0f;
    int i;
    glbk__rsm_face_axes(map, face, &r, &u, &a);
    p = glbk_rsm__v3_load(map->light.position);
    for (i = 0; i < 3; i++) {
        float axis = i == 0 ? a.x : i == 1 ? a.y : a.z;
        m[4 * i] = s * (i == 0 ? r.x : i == 1 ? r.y : r.z);
        m[4 * i + 1] = s * (i == 0 ? u.x : i == 1 ? u.y : u.z);
        m[4 * i + 2] = z0 * axis;
        m[4 * i + 3] = perspective ? axis : 0.0f;
    }
    m[12] = -s * glbk_rsm__v3_dot(r, p);
    m[13] = -s * glbk_rsm__v3_dot(u, p);
    m[14] = z1 - z0 * glbk_rsm__v3_dot(a, p);
    m[15] = perspective ? -glbk_rsm__v3_dot(a, p) : 1.0f;
}

/* Makes an image, which is an array unless layers is 0. */
static glbk_result glbk__rsm_image(glbk_context *ctx, glbk_format format, uint32_t width, uint32_t height,
                                   uint32_t layers, glbk_texture *out)
{
    glbk_texture_desc d;
    memset(&d, 0, sizeof d);
    d.format = format;
    d.width = width;
    d.height = height;
    d.layers = layers;
    return glbk_texture_create(ctx, &d, out);
}

/* Makes a framebuffer of layers first .. first + count - 1 of an image. */
static glbk_result glbk__rsm_target(glbk_context *ctx, const glbk_texture *texture, uint32_t first,
                                    uint32_t count, const glbk_texture *depth, glbk_target *out)
{
    glbk_target_desc d;
    uint32_t i;
    memset(&d, 0, sizeof d);
    for (i = 0; i < count; i++) {
        d.color[i] = texture;
        d.layer[i] = first + i;
    }
    d.depth = depth;
    return glbk__target_create(ctx, &d, out);
}

/* Makes all images and framebuffers of a map. */
static glbk_result glbk__rsm_map_images(glbk_context *ctx, glbk_rsm_map *map)
{
    uint32_t n = map->side, f, i;
    glbk_result result = glbk__rsm_image(ctx, GLBK_FORMAT_RGBA32UI, n, n, 3 * map->face_count, &map->texels);
    if (result == GLBK_OK) result = glbk__rsm_image(ctx, GLBK_FORMAT_DEPTH32F, n, n, 0, &map->depth);
    for (i = 0; i < 2; i++) {
        if (result == GLBK_OK)
            result = glbk__rsm_image(ctx, GLBK_FORMAT_R32UI, n, n, map->face_count, &map->sums[i]);
        if (result == GLBK_OK)
            result = glbk__rsm_image(ctx, GLBK_FORMAT_R32UI, n, 1, map->face_count, &map->rows[i]);
        for (f = 0; f < map->face_count && result == GLBK_OK; f++) {
            result = glbk__rsm_target(ctx, &map->sums[i], f, 1, NULL, &map->sum_targets[i][f]);
            if (result == GLBK_OK)
                result = glbk__rsm_target(ctx, &map->rows[i], f, 1, NULL, &map->row_targets[i][f]);
        }
    }
    for (f = 0; f < map->face_count && result == GLBK_OK; f++)
        result = glbk__rsm_target(ctx, &map->texels, 3 * f, 3, &map->depth, &map->face_targets[f]);
    return result;
}

GLBK_DEF glbk_result glbk_rsm_map_create(glbk_context *ctx, const rsm_light *light, uint32_t side,
                                         glbk_rsm_map *out)
{
    rsm_light checked;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    result = glbk__rsm_light_check(ctx, __func__, light, &checked);
    if (result != GLBK_OK) return result;
    if (side && (side < 4 || side > 4096))
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, __func__, "side", side, "0 or 4..4096");
    out->light = checked;
    out->face_count = glbk__rsm_face_count(&out->light);
    out->side = side ? side : out->face_count > 1 ? 256 : 512;
    glbk__rsm_set_block(out);
    result = glbk__rsm_map_images(ctx, out);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof out->block, &out->block, &out->buffer);
    if (result != GLBK_OK) glbk_rsm_map_free(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_rsm_map_place(glbk_context *ctx, glbk_rsm_map *map, const rsm_light *light)
{
    rsm_light checked;
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_map_check(ctx, __func__, map);
    if (result == GLBK_OK) result = glbk__rsm_light_check(ctx, __func__, light, &checked);
    if (result != GLBK_OK) return result;
    if (glbk__rsm_face_count(&checked) != map->face_count)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, __func__,
                                  "the number of faces that the light needs", glbk__rsm_face_count(&checked),
                                  "that of the map");
    map->light = checked;
    map->summed = 0;
    glbk__rsm_set_block(map);
    return glbk_buffer_update(ctx, &map->buffer, 0, sizeof map->block, &map->block);
}

/* Copies layer k of three out of an array of rsm_texel, whose elements have 16 bytes of each layer; if out is
   not 0, copies the layer into the array. */
static void glbk__rsm_copy_layer(unsigned char *texels, unsigned char *layer, size_t count, size_t k, int out)
{
    size_t i;
    for (i = 0; i < count; i++)
        if (out) memcpy(texels + 48 * i + 16 * k, layer + 16 * i, 16);
        else memcpy(layer + 16 * i, texels + 48 * i + 16 * k, 16);
}

GLBK_DEF glbk_result glbk_rsm_map_upload(glbk_context *ctx, glbk_rsm_map *map, const rsm_texel *texels)
{
    glbk_rsm__allocator memory;
    unsigned char *layer;
    size_t count;
    glbk_box box = { 0, 0, 0, 0, 0, 0, 1 };
    uint32_t i;
    glbk_result result = GLBK_OK;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_map_check(ctx, __func__, map);
    if (result != GLBK_OK) return result;
    if (!texels) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "texels", "is NULL");
    memory = glbk_rsm__memory(ctx);
    count = (size_t)map->side * map->side;
    layer = (unsigned char *)glbk_rsm__alloc_array(&memory, count, 64);
    if (!layer) return GLBK_ERR_ALLOC;
    box.width = box.height = map->side;
    for (i = 0; i < 3 * map->face_count && result == GLBK_OK; i++) {
        if (i % 3 == 0) memcpy(layer + 16 * count, texels + count * (i / 3), 48 * count);
        glbk__rsm_copy_layer(layer + 16 * count, layer, count, i % 3, 0);
        box.layer = i;
        result = glbk_texture_update(ctx, &map->texels, &box, layer);
    }
    glbk_rsm__free(&memory, layer);
    map->summed = 0;
    return result;
}

GLBK_DEF glbk_result glbk_rsm_map_read(glbk_context *ctx, const glbk_rsm_map *map, uint32_t face,
                                         rsm_texel *texels)
{
    glbk_rsm__allocator memory;
    unsigned char *layer;
    size_t count;
    uint32_t k;
    glbk_result result = GLBK_OK;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_map_check(ctx, __func__, map);
    if (result != GLBK_OK) return result;
    if (!texels) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "texels", "is NULL");
    if (face >= map->face_count)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "face", face, 0, map->face_count - 1.0);
    memory = glbk_rsm__memory(ctx);
    count = (size_t)map->side * map->side;
    layer = (unsigned char *)glbk_rsm__alloc_array(&memory, count, 16);
    if (!layer) return GLBK_ERR_ALLOC;
    for (k = 0; k < 3 && result == GLBK_OK; k++) {
        result = glbk_target_read(ctx, &map->face_targets[face], k, 0, 0, map->side, map->side, layer);
        if (result == GLBK_OK) glbk__rsm_copy_layer((unsigned char *)(void *)texels, layer, count, k, 1);
    }
    glbk_rsm__free(&memory, layer);
    return result;
}

GLBK_DEF void glbk_rsm_map_free(glbk_context *ctx, glbk_rsm_map *map)
{
    uint32_t i, f;
    if (!map) return;
    for (f = 0; f < 6; f++) {
        glbk_target_free(ctx, &map->face_targets[f]);
        for (i = 0; i < 2; i++) {
            glbk_target_free(ctx, &map->sum_targets[i][f]);
            glbk_target_free(ctx, &map->row_targets[i][f]);
        }
    }
    for (i = 0; i < 2; i++) {
        glbk_texture_free(ctx, &map->sums[i]);
        glbk_texture_free(ctx, &map->rows[i]);
    }
    glbk_target_free(ctx, &map->stats_target);
    glbk_texture_free(ctx, &map->stats);
    glbk_texture_free(ctx, &map->texels);
    glbk_texture_free(ctx, &map->depth);
    glbk_buffer_free(ctx, &map->buffer);
    memset(map, 0, sizeof *map);
}
