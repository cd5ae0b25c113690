/* ---- textures: formats, storage, and texels that go up ---- */

/* GL's constants of formats. */
enum {
    GLBK__RED = 0x1903, GLBK__RGBA = 0x1908, GLBK__RED_INTEGER = 0x8D94, GLBK__RGBA_INTEGER = 0x8D99,
    GLBK__RG_INTEGER = 0x8228, GLBK__RG = 0x8227, GLBK__DEPTH_COMPONENT = 0x1902, GLBK__R8 = 0x8229,
    GLBK__RGBA8 = 0x8058, GLBK__SRGB8_ALPHA8 = 0x8C43, GLBK__R8UI = 0x8232, GLBK__RGBA8UI = 0x8D7C,
    GLBK__R16UI = 0x8234, GLBK__RG16UI = 0x823A, GLBK__RGBA16UI = 0x8D76, GLBK__R32UI = 0x8236,
    GLBK__RG32UI = 0x823C, GLBK__RGBA32UI = 0x8D70, GLBK__R16F = 0x822D, GLBK__RGBA16F = 0x881A,
    GLBK__R32F = 0x822E, GLBK__RG32F = 0x8230, GLBK__RGBA32F = 0x8814, GLBK__DEPTH_COMPONENT24 = 0x81A6,
    GLBK__DEPTH_COMPONENT32F = 0x8CAC
};

/* GL's constants of textures, and of texels in memory. */
enum {
    GLBK__TEXTURE_BINDING_2D = 0x8069, GLBK__TEXTURE_BINDING_2D_ARRAY = 0x8C1D,
    GLBK__TEXTURE_MAX_LEVEL = 0x813D, GLBK__TEXTURE_MIN_FILTER = 0x2801, GLBK__TEXTURE_MAG_FILTER = 0x2800,
    GLBK__TEXTURE_WRAP_S = 0x2802, GLBK__TEXTURE_WRAP_T = 0x2803, GLBK__TEXTURE_COMPARE_MODE = 0x884C,
    GLBK__TEXTURE_COMPARE_FUNC = 0x884D, GLBK__COMPARE_REF_TO_TEXTURE = 0x884E, GLBK__LEQUAL = 0x0203,
    GLBK__NEAREST = 0x2600, GLBK__LINEAR = 0x2601, GLBK__NEAREST_MIPMAP_NEAREST = 0x2700,
    GLBK__LINEAR_MIPMAP_LINEAR = 0x2703, GLBK__REPEAT = 0x2901, GLBK__CLAMP_TO_EDGE = 0x812F,
    GLBK__UNPACK_SWAP_BYTES = 0x0CF0, GLBK__UNPACK_LSB_FIRST = 0x0CF1, GLBK__UNPACK_ROW_LENGTH = 0x0CF2,
    GLBK__UNPACK_SKIP_ROWS = 0x0CF3, GLBK__UNPACK_SKIP_PIXELS = 0x0CF4, GLBK__UNPACK_ALIGNMENT = 0x0CF5,
    GLBK__UNPACK_SKIP_IMAGES = 0x806D, GLBK__UNPACK_IMAGE_HEIGHT = 0x806E,
    GLBK__PACK_SWAP_BYTES = 0x0D00, GLBK__PACK_LSB_FIRST = 0x0D01, GLBK__PACK_ROW_LENGTH = 0x0D02,
    GLBK__PACK_SKIP_ROWS = 0x0D03, GLBK__PACK_SKIP_PIXELS = 0x0D04, GLBK__PACK_ALIGNMENT = 0x0D05,
    GLBK__PACK_SKIP_IMAGES = 0x806B, GLBK__PACK_IMAGE_HEIGHT = 0x806C,
    GLBK__PIXEL_PACK_BUFFER = 0x88EB, GLBK__PIXEL_UNPACK_BUFFER = 0x88EC,
    GLBK__PIXEL_PACK_BUFFER_BINDING = 0x88ED, GLBK__PIXEL_UNPACK_BUFFER_BINDING = 0x88EF
};

typedef struct glbk__format_info {
    uint16_t internal, format, type, bytes;         /* a texel */
} glbk__format_info;

/* In the order of glbk_format. */
static const glbk__format_info glbk__formats[] = {
    { 0, 0, 0, 0 },                                                 /* NONE */
    { 0, 0, 0, 0 },                                                 /* COLOR: resolved before */
    { GLBK__R8, GLBK__RED, GLBK_GL_UNSIGNED_BYTE, 1 },
    { GLBK__RGBA8, GLBK__RGBA, GLBK_GL_UNSIGNED_BYTE, 4 },
    { GLBK__SRGB8_ALPHA8, GLBK__RGBA, GLBK_GL_UNSIGNED_BYTE, 4 },
    { GLBK__R8UI, GLBK__RED_INTEGER, GLBK_GL_UNSIGNED_BYTE, 1 },
    { GLBK__RGBA8UI, GLBK__RGBA_INTEGER, GLBK_GL_UNSIGNED_BYTE, 4 },
    { GLBK__R16UI, GLBK__RED_INTEGER, GLBK_GL_UNSIGNED_SHORT, 2 },
    { GLBK__RG16UI, GLBK__RG_INTEGER, GLBK_GL_UNSIGNED_SHORT, 4 },
    { GLBK__RGBA16UI, GLBK__RGBA_INTEGER, GLBK_GL_UNSIGNED_SHORT, 8 },
    { GLBK__R32UI, GLBK__RED_INTEGER, GLBK_GL_UNSIGNED_INT, 4 },
    { GLBK__RG32UI, GLBK__RG_INTEGER, GLBK_GL_UNSIGNED_INT, 8 },
    { GLBK__RGBA32UI, GLBK__RGBA_INTEGER, GLBK_GL_UNSIGNED_INT, 16 },
    { GLBK__R16F, GLBK__RED, GLBK_GL_HALF_FLOAT, 2 },
    { GLBK__RGBA16F, GLBK__RGBA, GLBK_GL_HALF_FLOAT, 8 },
    { GLBK__R32F, GLBK__RED, GLBK_GL_FLOAT, 4 },
    { GLBK__RG32F, GLBK__RG, GLBK_GL_FLOAT, 8 },
    { GLBK__RGBA32F, GLBK__RGBA, GLBK_GL_FLOAT, 16 },
    { GLBK__DEPTH_COMPONENT24, GLBK__DEPTH_COMPONENT, GLBK_GL_UNSIGNED_INT, 4 },
    { GLBK__DEPTH_COMPONENT32F, GLBK__DEPTH_COMPONENT, GLBK_GL_FLOAT, 4 }
};

GLBK__DEF uint32_t glbk__texel_bytes(glbk_format format) { return glbk__formats[format].bytes; }

static int glbk__is_depth(glbk_format f) { return f == GLBK_FORMAT_DEPTH24 || f == GLBK_FORMAT_DEPTH32F; }

static int glbk__is_integer(glbk_format f)
{
    const uint32_t format = glbk__formats[f].format;
    return format == GLBK__RED_INTEGER || format == GLBK__RG_INTEGER || format == GLBK__RGBA_INTEGER;
}

static int glbk__is_float(glbk_format f)
{
    return !glbk__is_depth(f) &&
           (glbk__formats[f].type == GLBK_GL_FLOAT || glbk__formats[f].type == GLBK_GL_HALF_FLOAT);
}

/* Row lengths, offsets, byte order and pixel buffers that the user has set would change which bytes GL reads
   or writes; so a transfer sets them to its own values, and puts the user's back. */
enum { GLBK__UNPACK, GLBK__PACK, GLBK__STORE_COUNT = 8 };

static const uint32_t glbk__store_names[2][GLBK__STORE_COUNT] = {
    { GLBK__UNPACK_ALIGNMENT, GLBK__UNPACK_ROW_LENGTH, GLBK__UNPACK_SKIP_ROWS, GLBK__UNPACK_SKIP_PIXELS,
      GLBK__UNPACK_IMAGE_HEIGHT, GLBK__UNPACK_SKIP_IMAGES, GLBK__UNPACK_SWAP_BYTES, GLBK__UNPACK_LSB_FIRST },
    { GLBK__PACK_ALIGNMENT, GLBK__PACK_ROW_LENGTH, GLBK__PACK_SKIP_ROWS, GLBK__PACK_SKIP_PIXELS,
      GLBK__PACK_IMAGE_HEIGHT, GLBK__PACK_SKIP_IMAGES, GLBK__PACK_SWAP_BYTES, GLBK__PACK_LSB_FIRST }
};
static const uint32_t glbk__store_buffer[2][2] = {
    { GLBK__PIXEL_UNPACK_BUFFER, GLBK__PIXEL_UNPACK_BUFFER_BINDING },
    { GLBK__PIXEL_PACK_BUFFER, GLBK__PIXEL_PACK_BUFFER_BINDING }
};

/* Returns how many of them there are: ES knows the first six for unpacking, the first four for packing. */
static int glbk__store_count(const glbk_context *ctx, int way)
{
    return !ctx->es ? GLBK__STORE_COUNT : way == GLBK__UNPACK ? 6 : 4;
}

static void glbk__store_begin(const glbk_context *ctx, int way, glbk__store *old)
{
    int i;
    for (i = 0; i < glbk__store_count(ctx, way); i++) {
        ctx->gl.GetIntegerv(glbk__store_names[way][i], &old->value[i]);
        ctx->gl.PixelStorei(glbk__store_names[way][i], i == 0);
    }
    ctx->gl.GetIntegerv(glbk__store_buffer[way][1], &old->buffer);
    ctx->gl.BindBuffer(glbk__store_buffer[way][0], 0);
}

static void glbk__store_end(const glbk_context *ctx, int way, const glbk__store *old)
{
    int i;
    for (i = 0; i < glbk__store_count(ctx, way); i++)
        ctx->gl.PixelStorei(glbk__store_names[way][i], old->value[i]);
    ctx->gl.BindBuffer(glbk__store_buffer[way][0], (uint32_t)old->buffer);
}

static uint32_t glbk__binding_of(uint32_t gl_target)
{
    return gl_target == GLBK_GL_TEXTURE_2D ? GLBK__TEXTURE_BINDING_2D : GLBK__TEXTURE_BINDING_2D_ARRAY;
}

static uint32_t glbk__all_levels(uint32_t width, uint32_t height)
{
    uint32_t side = width > height ? width : height, levels = 1;
    while (side > 1) side /= 2, levels++;
    return levels;
}

/* Checks that the format allows the sampling, which is one of the enum. */
static glbk_result glbk__check_sampling(const glbk_context *ctx, const char *function,
                                        const glbk_texture_desc *d)
{
    const glbk_result bad = GLBK_ERR_DESC;
    if (d->sampling == GLBK_SAMPLING_COMPARE)
        return glbk__is_depth(d->format) ? GLBK_OK
                                         : glbk__refuse(ctx, bad, function, "desc.sampling",
                                                        "is COMPARE, which only depth formats have");
    if (d->sampling != GLBK_SAMPLING_LINEAR && d->sampling != GLBK_SAMPLING_MIPMAPS) return GLBK_OK;
    if (glbk__is_integer(d->format) || glbk__is_depth(d->format))
        return glbk__refuse(ctx, bad, function, "desc.sampling",
                            "is LINEAR or MIPMAPS, which formats of integers and depth do not have");
    if (glbk__formats[d->format].type == GLBK_GL_FLOAT && !ctx->float_linear)
        return glbk__refuse(ctx, bad, function, "desc.sampling",
                            "is LINEAR or MIPMAPS, which this context does not have for 32-bit floats");
    if (d->sampling == GLBK_SAMPLING_MIPMAPS && d->data && glbk__is_float(d->format) && !ctx->float_targets)
        return glbk__refuse(
            ctx, GLBK_ERR_FLOAT_TARGET, function, "desc.sampling",
            "is MIPMAPS, which this context makes of no floats, since it cannot draw to them");
    return GLBK_OK;
}

/* Checks a size: below `low` the desc is wrong, above `high` the context's limit is passed. */
static glbk_result glbk__check_extent(const glbk_context *ctx, const char *function, const char *field,
                                      uint32_t value, uint32_t low, uint32_t high)
{
    if (value >= low && value <= high) return GLBK_OK;
    return glbk__refuse_range(ctx, value > high ? GLBK_ERR_LIMIT : GLBK_ERR_DESC, function, field, value, low,
                              high);
}

/* Checks a desc and resolves its defaults in place. */
static glbk_result glbk__check_texture(const glbk_context *ctx, const char *function, glbk_texture_desc *d)
{
    uint32_t most;
    glbk_result result;
    if (d->format <= GLBK_FORMAT_NONE || d->format >= GLBK_FORMAT_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.format", (double)d->format,
                                  "a glbk_format, not NONE");
    if ((unsigned)d->sampling >= GLBK_SAMPLING_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.sampling", (double)d->sampling,
                                  "a glbk_sampling");
    if (d->format == GLBK_FORMAT_COLOR)
        d->format = ctx->float_targets ? GLBK_FORMAT_RGBA32F : GLBK_FORMAT_RGBA32UI;
    result = glbk__check_extent(ctx, function, "desc.width", d->width, 1, ctx->max_side);
    if (result == GLBK_OK)
        result = glbk__check_extent(ctx, function, "desc.height", d->height, 1, ctx->max_side);
    if (result == GLBK_OK)
        result = glbk__check_extent(ctx, function, "desc.layers", d->layers, 0, ctx->max_layers);
    if (result != GLBK_OK) return result;
    most = glbk__all_levels(d->width, d->height);
    if (!d->levels) d->levels = d->sampling == GLBK_SAMPLING_MIPMAPS ? most : 1;
    if (d->levels > most)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.levels", d->levels, 0, most);
    return glbk__check_sampling(ctx, function, d);
}

static uint32_t glbk__level_side(uint32_t size, uint32_t level) { return size >> level ? size >> level : 1; }

/* Allots all levels at once, on ES and WebGL. Makers of pyramids draw to a level while only the level below
   can be read (BASE_LEVEL, MAX_LEVEL), and ES does not allow that if the levels were allotted one by
   one. */
static void glbk__store_texture(const glbk_context *ctx, const glbk_texture_desc *d, uint32_t target)
{
    const glbk__format_info *f = &glbk__formats[d->format];
    const int32_t levels = (int32_t)d->levels, width = (int32_t)d->width, height = (int32_t)d->height;
    const int32_t layers = (int32_t)d->layers;
    if (layers) ctx->gl.TexStorage3D(target, levels, (uint32_t)f->internal, width, height, layers);
    else ctx->gl.TexStorage2D(target, levels, (uint32_t)f->internal, width, height);
    if (!d->data) return;
    if (layers) ctx->gl.TexSubImage3D(target, 0, 0, 0, 0, width, height, layers, f->format, f->type, d->data);
    else ctx->gl.TexSubImage2D(target, 0, 0, 0, width, height, f->format, f->type, d->data);
    if (d->sampling == GLBK_SAMPLING_MIPMAPS) ctx->gl.GenerateMipmap(target);
}

/* Gives the texture that is bound to target its storage and parameters. */
static void glbk__fill_texture(const glbk_context *ctx, const glbk_texture_desc *d, uint32_t target)
{
    const glbk__format_info *f = &glbk__formats[d->format];
    int linear = d->sampling == GLBK_SAMPLING_LINEAR || d->sampling == GLBK_SAMPLING_COMPARE;
    int mipmaps = d->sampling == GLBK_SAMPLING_MIPMAPS, wrap = d->repeat ? GLBK__REPEAT : GLBK__CLAMP_TO_EDGE;
    const int smaller = mipmaps         ? GLBK__LINEAR_MIPMAP_LINEAR
                        : linear        ? GLBK__LINEAR
                        : d->levels > 1 ? GLBK__NEAREST_MIPMAP_NEAREST
                                        : GLBK__NEAREST;
    uint32_t level;

    /* Parameters come first: Mesa allots levels by them, and otherwise forgets some of small arrays of
       integers. */
    ctx->gl.TexParameteri(target, GLBK__TEXTURE_MAX_LEVEL, (int32_t)d->levels - 1);
    ctx->gl.TexParameteri(target, GLBK__TEXTURE_MIN_FILTER, smaller);
    ctx->gl.TexParameteri(target, GLBK__TEXTURE_MAG_FILTER, mipmaps || linear ? GLBK__LINEAR : GLBK__NEAREST);
    ctx->gl.TexParameteri(target, GLBK__TEXTURE_WRAP_S, wrap);
    ctx->gl.TexParameteri(target, GLBK__TEXTURE_WRAP_T, wrap);
    if (d->sampling == GLBK_SAMPLING_COMPARE) {
        ctx->gl.TexParameteri(target, GLBK__TEXTURE_COMPARE_MODE, GLBK__COMPARE_REF_TO_TEXTURE);
        ctx->gl.TexParameteri(target, GLBK__TEXTURE_COMPARE_FUNC, GLBK__LEQUAL);
    }
    if (ctx->es) {
        glbk__store_texture(ctx, d, target);
        return;
    }
    for (level = 0; level < d->levels; level++) {
        int32_t width = (int32_t)glbk__level_side(d->width, level);
        int32_t height = (int32_t)glbk__level_side(d->height, level);
        const void *data = level == 0 ? d->data : NULL;
        if (d->layers)
            ctx->gl.TexImage3D(target, (int32_t)level, f->internal, width, height, (int32_t)d->layers, 0,
                               f->format, f->type, data);
        else
            ctx->gl.TexImage2D(target, (int32_t)level, f->internal, width, height, 0, f->format, f->type,
                               data);
    }
    if (mipmaps && d->data) ctx->gl.GenerateMipmap(target);
}

GLBK_DEF glbk_result glbk_texture_create(glbk_context *ctx, const glbk_texture_desc *desc, glbk_texture *out)
{
    glbk_texture_desc d;
    glbk__store store;
    int32_t bound = 0;
    glbk_result result;

    result = glbk__enter_create(ctx, __func__, out, sizeof *out);
    if (result != GLBK_OK) return result;
    if (!desc) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "desc", "is NULL");
    d = *desc;
    result = glbk__check_texture(ctx, __func__, &d);
    if (result != GLBK_OK) return result;
    out->gl_target = d.layers ? GLBK_GL_TEXTURE_2D_ARRAY : GLBK_GL_TEXTURE_2D;
    out->format = d.format;
    out->width = d.width;
    out->height = d.height;
    out->layers = d.layers;
    out->levels = d.levels;

    ctx->gl.GetIntegerv(glbk__binding_of(out->gl_target), &bound);
    glbk__store_begin(ctx, GLBK__UNPACK, &store);
    ctx->gl.GenTextures(1, &out->name);
    ctx->gl.BindTexture(out->gl_target, out->name);
    glbk__fill_texture(ctx, &d, out->gl_target);
    ctx->gl.BindTexture(out->gl_target, (uint32_t)bound);
    glbk__store_end(ctx, GLBK__UNPACK, &store);
    result = glbk__leave(ctx);
    if (result != GLBK_OK) glbk_texture_free(ctx, out);
    return result;
}

GLBK__DEF void glbk__upload_begin(const glbk_context *ctx, const glbk_texture *t, glbk__upload *old)
{
    old->bound = 0;
    ctx->gl.GetIntegerv(glbk__binding_of(t->gl_target), &old->bound);
    glbk__store_begin(ctx, GLBK__UNPACK, &old->store);
    ctx->gl.BindTexture(t->gl_target, t->name);
}

GLBK__DEF void glbk__upload_end(const glbk_context *ctx, const glbk_texture *t, const glbk__upload *old)
{
    ctx->gl.BindTexture(t->gl_target, (uint32_t)old->bound);
    glbk__store_end(ctx, GLBK__UNPACK, &old->store);
}

GLBK__DEF void glbk__upload_box(const glbk_context *ctx, const glbk_texture *t, const glbk_box *b,
                             const void *data)
{
    const glbk__format_info *f = &glbk__formats[t->format];
    const int32_t level = (int32_t)b->level, x = (int32_t)b->x, y = (int32_t)b->y;
    const int32_t width = (int32_t)b->width, height = (int32_t)b->height;
    if (t->layers)
        ctx->gl.TexSubImage3D(t->gl_target, level, x, y, (int32_t)b->layer, width, height,
                              b->layers ? (int32_t)b->layers : 1, f->format, f->type, data);
    else
        ctx->gl.TexSubImage2D(t->gl_target, level, x, y, width, height, f->format, f->type, data);
}

/* Checks where a run of texels or layers ends. */
static glbk_result glbk__check_span(const glbk_context *ctx, const char *function, const char *field,
                                    uint64_t end, uint64_t most)
{
    return end <= most
               ? GLBK_OK
               : glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, function, field, (double)end, 0, (double)most);
}

/* Checks that a box lies within the texture. */
static glbk_result glbk__check_box(const glbk_context *ctx, const char *function, const glbk_texture *t,
                                   const glbk_box *b)
{
    glbk_result result;
    if (b->level >= t->levels)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, function, "box.level", b->level, 0,
                                  (double)t->levels - 1);
    result = glbk__check_span(ctx, function, "box.x + box.width", (uint64_t)b->x + b->width,
                              glbk__level_side(t->width, b->level));
    if (result == GLBK_OK)
        result = glbk__check_span(ctx, function, "box.y + box.height", (uint64_t)b->y + b->height,
                                  glbk__level_side(t->height, b->level));
    if (result == GLBK_OK)
        result =
            glbk__check_span(ctx, function, "box.layer + box.layers",
                             (uint64_t)b->layer + (b->layers ? b->layers : 1), t->layers ? t->layers : 1);
    return result;
}

GLBK_DEF glbk_result glbk_texture_update(glbk_context *ctx, const glbk_texture *t, const glbk_box *box,
                                         const void *data)
{
    glbk__upload old;
    glbk_result result = glbk__enter_frame(ctx);

    if (result != GLBK_OK) return result;
    if (!t || !t->name) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "texture", "was not created");
    if (!box) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "box", "is NULL");
    if (!data) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "data", "is NULL");
    result = glbk__check_box(ctx, __func__, t, box);
    if (result != GLBK_OK) return result;
    glbk__upload_begin(ctx, t, &old);
    glbk__upload_box(ctx, t, box, data);
    glbk__upload_end(ctx, t, &old);
    return glbk__leave_frame(ctx);
}

GLBK_DEF void glbk_texture_free(glbk_context *ctx, glbk_texture *texture)
{
    if (!texture) return;
    if (ctx && !ctx->lost && texture->name) ctx->gl.DeleteTextures(1, &texture->name);
    memset(texture, 0, sizeof *texture);
}
