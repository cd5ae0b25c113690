/* ---- init: functions and what the context can do ---- */

enum {
    GLBK__RENDERER = 0x1F01, GLBK__VERSION_TEXT = 0x1F02, GLBK__EXTENSIONS = 0x1F03,
    GLBK__NUM_EXTENSIONS = 0x821D, GLBK__CLIP_ORIGIN = 0x935C, GLBK__CLIP_DEPTH_MODE = 0x935D,
    GLBK__LOWER_LEFT = 0x8CA1, GLBK__UPPER_LEFT = 0x8CA2, GLBK__NEGATIVE_ONE_TO_ONE = 0x935E,
    GLBK__MAX_TEXTURE_SIZE = 0x0D33, GLBK__MAX_ARRAY_TEXTURE_LAYERS = 0x88FF, GLBK__MAX_DRAW_BUFFERS = 0x8824,
    GLBK__MAX_SHADER_STORAGE_BLOCK_SIZE = 0x90DE, GLBK__ALIASED_POINT_SIZE_RANGE = 0x846D,
    GLBK__MAX_TEXTURE_UNITS = 0x8B4D /* MAX_COMBINED_TEXTURE_IMAGE_UNITS */,
    GLBK__MAX_BLOCK_BINDINGS = 0x8A2F /* MAX_UNIFORM_BUFFER_BINDINGS */
};

enum {
    GLBK__GROUP_CORE, GLBK__GROUP_ES, GLBK__GROUP_DESK, GLBK__GROUP_TARGETS, GLBK__GROUP_BLENDS,
    GLBK__GROUP_COMPUTE, GLBK__GROUP_CLIP, GLBK__GROUP_CLAMP
};

/* The names without "gl", one after the other, each ended by 0, and their groups, in the order of
   glbk_functions, which holds nothing but pointers to them: a table of pointers to names would be six times
   as large in a program that can be moved. */
static const char glbk__function_names[] =
#define GLBK__ENTRY(group, type, name, parameters) #name "\0"
    GLBK_FUNCTIONS(GLBK__ENTRY);
#undef GLBK__ENTRY

static const uint8_t glbk__function_groups[] = {
#define GLBK__ENTRY(group, type, name, parameters) GLBK__GROUP_##group,
    GLBK_FUNCTIONS(GLBK__ENTRY)
#undef GLBK__ENTRY
};

/* Loads one group. Returns the name, without "gl", of a function that is missing, or NULL. */
static const char *glbk__load(glbk_context *ctx, const glbk_desc *desc, int group)
{
    const char *next = glbk__function_names;
    size_t i;
    for (i = 0; i < sizeof glbk__function_groups; i++, next += strlen(next) + 1) {
        const char *name = next;
        char whole[64] = "gl";
        glbk_proc_fn proc;
        if (glbk__function_groups[i] != group) continue;
        if (strcmp(name, "Barrier") == 0) name = "MemoryBarrier";
        if (group == GLBK__GROUP_CLIP && ctx->es) name = "ClipControlEXT";
        memcpy(whole + 2, name, strlen(name) + 1);
        proc = desc->get_proc_fn(whole, desc->user);
        if (!proc) return name;
        memcpy((char *)&ctx->gl + i * sizeof proc, &proc, sizeof proc);
    }
    return NULL;
}

/* Reads the version, the first number of a text like "4.5 (Core Profile) ...", "OpenGL ES 3.0 ..." or "OpenGL
   ES 3.0 (WebGL 2.0 ...)". */
static void glbk__read_version(glbk_context *ctx, const char *text)
{
    const char *s = text;
    uint32_t major = 0;
    ctx->es = strstr(text, "OpenGL ES") != NULL;
    ctx->webgl = strstr(text, "WebGL") != NULL;
    ctx->version = 0;
    while (*s && (*s < '0' || *s > '9')) s++;
    while (*s >= '0' && *s <= '9' && major < 100) major = 10 * major + (uint32_t)(*s++ - '0');
    if (s[0] == '.' && s[1] >= '0' && s[1] <= '9') ctx->version = 100 * major + 10 * (uint32_t)(s[1] - '0');
}

static int glbk__has_extension(const glbk_context *ctx, const char *name)
{
    int32_t count = 0, i;
    ctx->gl.GetIntegerv(GLBK__NUM_EXTENSIONS, &count);
    for (i = 0; i < count; i++) {
        const char *text = (const char *)ctx->gl.GetStringi(GLBK__EXTENSIONS, (uint32_t)i);
        if (text && strcmp(text, name) == 0) return 1;
    }
    return 0;
}

GLBK__DEF uint32_t glbk__get_integer(const glbk_context *ctx, uint32_t name)
{
    int32_t value[4] = { 0, 0, 0, 0 };
    ctx->gl.GetIntegerv(name, value);
    return (uint32_t)value[0];
}

/* Returns whether glClipControl works. WebGL also lists extensions that nobody has enabled; GL does not know
   their state then, which shows in the origin. */
static int glbk__has_clip_control(glbk_context *ctx, const glbk_desc *desc)
{
    uint32_t origin;
    if (!ctx->es && ctx->version < 450 && !glbk__has_extension(ctx, "GL_ARB_clip_control")) return 0;
    if (ctx->es && !glbk__has_extension(ctx, "GL_EXT_clip_control")) return 0;
    if (glbk__load(ctx, desc, GLBK__GROUP_CLIP)) return 0;
    origin = glbk__get_integer(ctx, GLBK__CLIP_ORIGIN);
    if (origin == GLBK__LOWER_LEFT || origin == GLBK__UPPER_LEFT) return 1;
    ctx->gl.GetError();
    return 0;
}

static void glbk__read_features(glbk_context *ctx, const glbk_desc *desc)
{
    float points[2] = { 1, 1 };
    int es32 = ctx->es && ctx->version >= 320, desk = !ctx->es;

    ctx->float_targets = desk || es32 || glbk__has_extension(ctx, "GL_EXT_color_buffer_float");
    ctx->float_blend = desk || es32 || (ctx->float_targets && glbk__has_extension(ctx, "GL_EXT_float_blend"));
    ctx->float_linear = desk || glbk__has_extension(ctx, "GL_OES_texture_float_linear");
    ctx->compute =
        desk && ctx->version >= 430 && !desc->core_only && !glbk__load(ctx, desc, GLBK__GROUP_COMPUTE);
    ctx->clip_control = glbk__has_clip_control(ctx, desc);
    ctx->each_target = desk || (es32 && !glbk__load(ctx, desc, GLBK__GROUP_TARGETS));
    ctx->each_blend =
        ctx->each_target && (es32 || ctx->version >= 400) && !glbk__load(ctx, desc, GLBK__GROUP_BLENDS);
    ctx->offset_clamp = desk &&
                        (ctx->version >= 460 || glbk__has_extension(ctx, "GL_ARB_polygon_offset_clamp")) &&
                        !glbk__load(ctx, desc, GLBK__GROUP_CLAMP);
    ctx->max_side = glbk__get_integer(ctx, GLBK__MAX_TEXTURE_SIZE);
    ctx->max_layers = glbk__get_integer(ctx, GLBK__MAX_ARRAY_TEXTURE_LAYERS);
    ctx->max_targets = glbk__get_integer(ctx, GLBK__MAX_DRAW_BUFFERS);
    if (ctx->max_targets > 8) ctx->max_targets = 8;
    if (ctx->compute) ctx->max_storage = glbk__get_integer(ctx, GLBK__MAX_SHADER_STORAGE_BLOCK_SIZE);
    ctx->gl.GetFloatv(GLBK__ALIASED_POINT_SIZE_RANGE, points);
    ctx->max_point_side = points[1];
}

/* Checks that `least` bindings from `first` on are among the `has` ones of the context, and writes how many
   there are, up to `most`. */
static glbk_result glbk__check_first(const glbk_context *ctx, const char *field, uint32_t first, uint32_t has,
                                     uint32_t least, uint32_t most, uint32_t *out)
{
    const uint32_t last = has > least ? has - least : 0;
    if (first > last) return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, "glbk_init", field, first, 0, last);
    *out = has - first < most ? has - first : most;
    return GLBK_OK;
}

static glbk_result glbk__init(glbk_context *ctx, const glbk_desc *desc)
{
    const char *missing, *version;
    glbk_result result;

    missing = glbk__load(ctx, desc, GLBK__GROUP_CORE);
    if (missing) return glbk__fail(ctx, GLBK_ERR_FUNCTION, "glbk_init: missing: gl", missing);
    version = (const char *)ctx->gl.GetString(GLBK__VERSION_TEXT);
    if (!version) return glbk__fail(ctx, GLBK_ERR_CONTEXT, "glbk_init: ", "no GL context is current");
    result = glbk__take_errors(ctx, GLBK_ERR_PENDING);
    if (result != GLBK_OK) return result;
    glbk__read_version(ctx, version);
    if (ctx->version < (ctx->es ? 300u : 330u))
        return glbk__fail(ctx, GLBK_ERR_OLD_CONTEXT, "glbk_init: this is OpenGL ", version);
    missing = glbk__load(ctx, desc, ctx->es ? GLBK__GROUP_ES : GLBK__GROUP_DESK);
    if (!missing && !ctx->es) missing = glbk__load(ctx, desc, GLBK__GROUP_TARGETS);
    if (missing) return glbk__fail(ctx, GLBK_ERR_FUNCTION, "glbk_init: missing: gl", missing);
    ctx->renderer = (const char *)ctx->gl.GetString(GLBK__RENDERER);
    if (!ctx->renderer) ctx->renderer = "";
    glbk__read_features(ctx, desc);
    result = glbk__check_first(ctx, "desc.first_unit", desc->first_unit,
                               glbk__get_integer(ctx, GLBK__MAX_TEXTURE_UNITS), GLBK_UNITS, GLBK_MAX_UNITS,
                               &ctx->unit_count);
    if (result == GLBK_OK)
        result = glbk__check_first(ctx, "desc.first_block", desc->first_block,
                                   glbk__get_integer(ctx, GLBK__MAX_BLOCK_BINDINGS), GLBK_BLOCKS,
                                   GLBK_MAX_BLOCKS, &ctx->block_count);
    if (result != GLBK_OK) return result;
    ctx->gl.GenVertexArrays(1, &ctx->vertex_array);
    ctx->gl.GenBuffers(1, &ctx->shown);
    return glbk__leave(ctx);
}

GLBK_DEF glbk_result glbk_init(glbk_context *ctx, const glbk_desc *desc)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    memset(ctx, 0, sizeof *ctx);
    if (!desc) return GLBK_ERR_ARGUMENT;
    ctx->system = desc->system;
    ctx->first_unit = desc->first_unit;
    ctx->first_block = desc->first_block;
    ctx->check = desc->check != 0;
    if (!desc->get_proc_fn)
        result = glbk__refuse(ctx, GLBK_ERR_DESC, __func__, "desc.get_proc_fn", "is NULL");
    else if (!glbk__allocator_valid(desc->system.allocator.alloc_fn, desc->system.allocator.free_fn))
        result = glbk__refuse(ctx, GLBK_ERR_DESC, __func__, "desc.system.allocator",
                              "has one of its two functions");
    else
        result = glbk__init(ctx, desc);
    if (result != GLBK_OK) glbk_free(ctx);
    return result;
}

GLBK_DEF void glbk_free(glbk_context *ctx)
{
    if (!ctx) return;
    if (ctx->vertex_array && !ctx->lost) ctx->gl.DeleteVertexArrays(1, &ctx->vertex_array);
    if (ctx->shown && !ctx->lost) ctx->gl.DeleteBuffers(1, &ctx->shown);
    memset(ctx, 0, sizeof *ctx);
    ctx->lost = 1;
}

GLBK_DEF void glbk_abandon(glbk_context *ctx)
{
    if (ctx) ctx->lost = 1;
}
