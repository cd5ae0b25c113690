/* ---- state: what passes touch ---- */

/* Capabilities: GL's name and constant, where there is such a capability, and the value that a pass needs.
   BOTH are in both dialects, DESK in OpenGL alone. PROGRAM_POINT_SIZE, MULTISAMPLE and
   TEXTURE_CUBE_MAP_SEAMLESS are on, because ES has no switch for them and behaves so; the others must not
   interfere. FRAMEBUFFER_SRGB is for targets alone that have such a format, which ES encodes, too: the user
   decides about other framebuffers. */
#define GLBK__COMMON_CAPS(X)                                                                            \
    X(BLEND, 0x0BE2, BOTH, 0) X(DEPTH_TEST, 0x0B71, BOTH, 0) X(CULL_FACE, 0x0B44, BOTH, 0)              \
    X(POLYGON_OFFSET_FILL, 0x8037, BOTH, 0) X(SCISSOR_TEST, 0x0C11, BOTH, 0)                            \
    X(STENCIL_TEST, 0x0B90, BOTH, 0) X(DITHER, 0x0BD0, BOTH, 0)                                         \
    X(SAMPLE_ALPHA_TO_COVERAGE, 0x809E, BOTH, 0) X(SAMPLE_COVERAGE, 0x80A0, BOTH, 0)                    \
    X(RASTERIZER_DISCARD, 0x8C89, BOTH, 0) X(PRIMITIVE_RESTART_FIXED_INDEX, 0x8D69, RESTART, 0)
#define GLBK__DESK_CAPS(X)                                                                              \
    X(PRIMITIVE_RESTART, 0x8F9D, DESK, 0) X(COLOR_LOGIC_OP, 0x0BF2, DESK, 0)                            \
    X(DEPTH_CLAMP, 0x864F, DESK, 0) X(SAMPLE_ALPHA_TO_ONE, 0x809F, DESK, 0)                             \
    X(SAMPLE_MASK, 0x8E51, DESK, 0) X(POLYGON_SMOOTH, 0x0B41, DESK, 0) X(LINE_SMOOTH, 0x0B20, DESK, 0)  \
    X(POLYGON_OFFSET_LINE, 0x2A02, DESK, 0) X(POLYGON_OFFSET_POINT, 0x2A01, DESK, 0)                    \
    X(PROGRAM_POINT_SIZE, 0x8642, DESK, 1) X(MULTISAMPLE, 0x809D, DESK, 1)                              \
    X(FRAMEBUFFER_SRGB, 0x8DB9, SRGB, 1) X(TEXTURE_CUBE_MAP_SEAMLESS, 0x884F, DESK, 1)
#define GLBK__CLIP_CAPS(X)                                                                              \
    X(CLIP_DISTANCE0, 0x3000, DESK, 0) X(CLIP_DISTANCE1, 0x3001, DESK, 0)                               \
    X(CLIP_DISTANCE2, 0x3002, DESK, 0) X(CLIP_DISTANCE3, 0x3003, DESK, 0)                               \
    X(CLIP_DISTANCE4, 0x3004, DESK, 0) X(CLIP_DISTANCE5, 0x3005, DESK, 0)                               \
    X(CLIP_DISTANCE6, 0x3006, DESK, 0) X(CLIP_DISTANCE7, 0x3007, DESK, 0)
#define GLBK__CAPS(X) GLBK__COMMON_CAPS(X) GLBK__DESK_CAPS(X) GLBK__CLIP_CAPS(X)

enum {
    GLBK__CAP_BOTH, GLBK__CAP_DESK, GLBK__CAP_RESTART, GLBK__CAP_SRGB,
#define GLBK__ENTRY(name, gl, group, value) GLBK__##name = gl,
    GLBK__CAPS(GLBK__ENTRY)
#undef GLBK__ENTRY
};

static const struct { uint16_t name; uint8_t group, value; } glbk__caps[] = {
#define GLBK__ENTRY(name, gl, group, value) { gl, GLBK__CAP_##group, value },
    GLBK__CAPS(GLBK__ENTRY)
#undef GLBK__ENTRY
};
enum { GLBK__CAP_COUNT = sizeof glbk__caps / sizeof glbk__caps[0] };

static int glbk__has_cap(const glbk_context *ctx, int i)
{
    if (glbk__caps[i].group == GLBK__CAP_RESTART)
        return ctx->es ? !ctx->webgl : ctx->version >= 430;     /* WebGL has no switch: primitives restart */
    return glbk__caps[i].group == GLBK__CAP_BOTH || !ctx->es;
}

GLBK__DEF void glbk__set_cap(const glbk_context *ctx, uint32_t name, int on)
{
    if (on) ctx->gl.Enable(name);
    else ctx->gl.Disable(name);
}

/* Whole numbers: GL's name for asking, and the one that GLBK__W_ is followed by. */
#define GLBK__WORDS(X)                                                                                  \
    X(PROGRAM, GLBK__CURRENT_PROGRAM_NAME) X(VERTEX_ARRAY, GLBK__VERTEX_ARRAY_BINDING)                  \
    X(TARGET, GLBK__DRAW_FRAMEBUFFER_BINDING) X(UNIT, GLBK__ACTIVE_TEXTURE)                             \
    X(BLOCK, GLBK__UNIFORM_BUFFER_BINDING) X(DEPTH_FUNC, GLBK__DEPTH_FUNC)                              \
    X(CULL_MODE, GLBK__CULL_FACE_MODE) X(FRONT, GLBK__FRONT_FACE)                                       \
    X(SOURCE_RGB, GLBK__BLEND_SRC_RGB) X(DEST_RGB, GLBK__BLEND_DST_RGB)                                 \
    X(SOURCE_ALPHA, GLBK__BLEND_SRC_ALPHA) X(DEST_ALPHA, GLBK__BLEND_DST_ALPHA)                         \
    X(EQUATION_RGB, GLBK__BLEND_EQUATION_RGB) X(EQUATION_ALPHA, GLBK__BLEND_EQUATION_ALPHA)

enum {
    GLBK__CURRENT_PROGRAM_NAME = 0x8B8D,
    GLBK__VERTEX_ARRAY_BINDING = 0x85B5,
    GLBK__ACTIVE_TEXTURE = 0x84E0,
    GLBK__DEPTH_FUNC = 0x0B74,
    GLBK__CULL_FACE_MODE = 0x0B45,
    GLBK__FRONT_FACE = 0x0B46,
    GLBK__BLEND_SRC_RGB = 0x80C9,
    GLBK__BLEND_DST_RGB = 0x80C8,
    GLBK__BLEND_SRC_ALPHA = 0x80CB,
    GLBK__BLEND_DST_ALPHA = 0x80CA,
    GLBK__BLEND_EQUATION_RGB = 0x8009,
    GLBK__BLEND_EQUATION_ALPHA = 0x883D,
    GLBK__COLOR_WRITEMASK = 0x0C23,
    GLBK__SAMPLER_BINDING = 0x8919,
    GLBK__UNIFORM_BUFFER_BINDING = 0x8A28,
    GLBK__UNIFORM_BUFFER_START = 0x8A29,
    GLBK__UNIFORM_BUFFER_BYTES = 0x8A2A /* UNIFORM_BUFFER_SIZE */,
    GLBK__STORAGE_BUFFER_BINDING = 0x90D3,
    GLBK__STORAGE_BUFFER_START = 0x90D4,
    GLBK__STORAGE_BUFFER_BYTES = 0x90D5,
    GLBK__DISPATCH_INDIRECT_BUFFER_BINDING = 0x90EF,
    GLBK__IMAGE_BINDING_NAME = 0x8F3A,
    GLBK__IMAGE_BINDING_LEVEL = 0x8F3B,
    GLBK__IMAGE_BINDING_LAYERED = 0x8F3C,
    GLBK__IMAGE_BINDING_LAYER = 0x8F3D,
    GLBK__IMAGE_BINDING_ACCESS = 0x8F3E,
    GLBK__IMAGE_BINDING_FORMAT = 0x906E,
    GLBK__POLYGON_MODE = 0x0B40,
    GLBK__FRONT_AND_BACK = 0x0408,
    GLBK__FILL = 0x1B02,
    GLBK__VIEWPORT = 0x0BA2,
    GLBK__DEPTH_WRITEMASK = 0x0B72,
    GLBK__DEPTH_RANGE = 0x0B70,
    GLBK__POLYGON_OFFSET_FACTOR = 0x8038,
    GLBK__POLYGON_OFFSET_UNITS = 0x2A00,
    GLBK__POLYGON_OFFSET_CLAMP = 0x8E1B
};

enum {
#define GLBK__ENTRY(name, gl) GLBK__W_##name,
    GLBK__WORDS(GLBK__ENTRY)
#undef GLBK__ENTRY
    GLBK__WORD_COUNT,
    GLBK__W_STORAGE = GLBK__WORD_COUNT, GLBK__W_GROUPS, GLBK__W_ORIGIN, GLBK__W_CLIP_DEPTH, GLBK__W_POLYGON,
    GLBK__W_POLYGON_2
};

static const uint16_t glbk__word_names[] = {
#define GLBK__ENTRY(name, gl) gl,
    GLBK__WORDS(GLBK__ENTRY)
#undef GLBK__ENTRY
};

enum { GLBK__BLEND_WORDS = 6 };     /* the words from SOURCE_RGB to EQUATION_ALPHA */

static void glbk__save_indexed(glbk_context *ctx, glbk_state *s)
{
    uint32_t i, k;
    if (!ctx->each_target) {
        ctx->gl.GetBooleanv(GLBK__COLOR_WRITEMASK, s->color_mask[0]);
        return;
    }
    for (i = 0; i < ctx->max_targets; i++) {
        s->blend[i] = ctx->gl.IsEnabledi(GLBK__BLEND, i);
        ctx->gl.GetBooleani_v(GLBK__COLOR_WRITEMASK, i, s->color_mask[i]);
        for (k = 0; k < GLBK__BLEND_WORDS && ctx->each_blend; k++)
            ctx->gl.GetIntegeri_v(glbk__word_names[GLBK__W_SOURCE_RGB + k], i, &s->blends[i][k]);
    }
}

static const uint16_t glbk__image_names[6] = { GLBK__IMAGE_BINDING_NAME,    GLBK__IMAGE_BINDING_LEVEL,
                                               GLBK__IMAGE_BINDING_LAYERED, GLBK__IMAGE_BINDING_LAYER,
                                               GLBK__IMAGE_BINDING_ACCESS,  GLBK__IMAGE_BINDING_FORMAT };

static void glbk__save_images(glbk_context *ctx, glbk_state *s)
{
    uint32_t i, k;
    for (i = 0; i < GLBK_IMAGES; i++)
        for (k = 0; k < 6; k++) ctx->gl.GetIntegeri_v(glbk__image_names[k], i, &s->images[i][k]);
}

static void glbk__restore_images(glbk_context *ctx, const glbk_state *s)
{
    uint32_t i;
    for (i = 0; i < GLBK_IMAGES; i++) {
        const int32_t *m = s->images[i];
        ctx->gl.BindImageTexture(i, (uint32_t)m[0], m[1], (uint8_t)(m[2] != 0), m[3], (uint32_t)m[4],
                                 (uint32_t)m[5]);
    }
}

static void glbk__save_bindings(glbk_context *ctx, glbk_state *s)
{
    uint32_t i;
    for (i = 0; i < ctx->unit_count; i++) {
        ctx->gl.ActiveTexture(GLBK_GL_TEXTURE0 + ctx->first_unit + i);
        ctx->gl.GetIntegerv(GLBK__TEXTURE_BINDING_2D, &s->units[i][0]);
        ctx->gl.GetIntegerv(GLBK__TEXTURE_BINDING_2D_ARRAY, &s->units[i][1]);
        ctx->gl.GetIntegerv(GLBK__SAMPLER_BINDING, &s->units[i][2]);
    }
    ctx->gl.ActiveTexture((uint32_t)s->words[GLBK__W_UNIT]);
    for (i = 0; i < ctx->block_count; i++) {
        ctx->gl.GetIntegeri_v(GLBK__UNIFORM_BUFFER_BINDING, ctx->first_block + i, &s->blocks[i]);
        ctx->gl.GetInteger64i_v(GLBK__UNIFORM_BUFFER_START, ctx->first_block + i, &s->ranges[i][0]);
        ctx->gl.GetInteger64i_v(GLBK__UNIFORM_BUFFER_BYTES, ctx->first_block + i, &s->ranges[i][1]);
    }
    for (i = 0; i < GLBK_BLOCKS && ctx->compute; i++) {
        ctx->gl.GetIntegeri_v(GLBK__STORAGE_BUFFER_BINDING, i, &s->storage[i]);
        ctx->gl.GetInteger64i_v(GLBK__STORAGE_BUFFER_START, i, &s->storage_ranges[i][0]);
        ctx->gl.GetInteger64i_v(GLBK__STORAGE_BUFFER_BYTES, i, &s->storage_ranges[i][1]);
    }
}

GLBK_DEF void glbk_state_save(glbk_context *ctx, glbk_state *out)
{
    int i;
    if (!out) return;
    memset(out, 0, sizeof *out);
    if (!ctx || ctx->lost) return;
    for (i = 0; i < GLBK__CAP_COUNT; i++)
        if (glbk__has_cap(ctx, i)) out->caps[i] = ctx->gl.IsEnabled(glbk__caps[i].name);
    for (i = 0; i < GLBK__WORD_COUNT; i++) ctx->gl.GetIntegerv(glbk__word_names[i], &out->words[i]);
    if (ctx->compute) {
        ctx->gl.GetIntegerv(GLBK__STORAGE_BUFFER_BINDING, &out->words[GLBK__W_STORAGE]);
        ctx->gl.GetIntegerv(GLBK__DISPATCH_INDIRECT_BUFFER_BINDING, &out->words[GLBK__W_GROUPS]);
        glbk__save_images(ctx, out);
    }
    if (ctx->clip_control) {
        ctx->gl.GetIntegerv(GLBK__CLIP_ORIGIN, &out->words[GLBK__W_ORIGIN]);
        ctx->gl.GetIntegerv(GLBK__CLIP_DEPTH_MODE, &out->words[GLBK__W_CLIP_DEPTH]);
    }
    if (!ctx->es) ctx->gl.GetIntegerv(GLBK__POLYGON_MODE, &out->words[GLBK__W_POLYGON]);    /* writes two */
    ctx->gl.GetIntegerv(GLBK__VIEWPORT, out->viewport);
    ctx->gl.GetBooleanv(GLBK__DEPTH_WRITEMASK, &out->depth_mask);
    ctx->gl.GetFloatv(GLBK__DEPTH_RANGE, out->floats);
    ctx->gl.GetFloatv(GLBK__POLYGON_OFFSET_FACTOR, out->floats + 2);
    ctx->gl.GetFloatv(GLBK__POLYGON_OFFSET_UNITS, out->floats + 3);
    if (ctx->offset_clamp) ctx->gl.GetFloatv(GLBK__POLYGON_OFFSET_CLAMP, &out->offset_clamp);
    glbk__save_indexed(ctx, out);
    glbk__save_bindings(ctx, out);
}

static void glbk__restore_indexed(glbk_context *ctx, const glbk_state *s)
{
    const uint8_t(*mask)[4] = s->color_mask;
    uint32_t i;
    if (!ctx->each_target) {
        ctx->gl.ColorMask(mask[0][0], mask[0][1], mask[0][2], mask[0][3]);
        return;
    }
    for (i = 0; i < ctx->max_targets; i++) {
        const int32_t *b = s->blends[i];
        if (s->blend[i]) ctx->gl.Enablei(GLBK__BLEND, i);
        else ctx->gl.Disablei(GLBK__BLEND, i);
        ctx->gl.ColorMaski(i, mask[i][0], mask[i][1], mask[i][2], mask[i][3]);
        if (!ctx->each_blend) continue;
        ctx->gl.BlendFuncSeparatei(i, (uint32_t)b[0], (uint32_t)b[1], (uint32_t)b[2], (uint32_t)b[3]);
        ctx->gl.BlendEquationSeparatei(i, (uint32_t)b[4], (uint32_t)b[5]);
    }
}

static void glbk__restore_range(glbk_context *ctx, uint32_t target, uint32_t index, int32_t name,
                                const int64_t range[2])
{
    if (name && range[1])
        ctx->gl.BindBufferRange(target, index, (uint32_t)name, (ptrdiff_t)range[0], (ptrdiff_t)range[1]);
    else ctx->gl.BindBufferBase(target, index, (uint32_t)name);
}

static void glbk__restore_bindings(glbk_context *ctx, const glbk_state *s)
{
    uint32_t i;
    for (i = 0; i < ctx->unit_count; i++) {
        ctx->gl.ActiveTexture(GLBK_GL_TEXTURE0 + ctx->first_unit + i);
        ctx->gl.BindTexture(GLBK_GL_TEXTURE_2D, (uint32_t)s->units[i][0]);
        ctx->gl.BindTexture(GLBK_GL_TEXTURE_2D_ARRAY, (uint32_t)s->units[i][1]);
        ctx->gl.BindSampler(ctx->first_unit + i, (uint32_t)s->units[i][2]);
    }
    ctx->gl.ActiveTexture((uint32_t)s->words[GLBK__W_UNIT]);
    for (i = 0; i < ctx->block_count; i++)
        glbk__restore_range(ctx, GLBK_GL_UNIFORM_BUFFER, ctx->first_block + i, s->blocks[i], s->ranges[i]);
    for (i = 0; i < GLBK_BLOCKS && ctx->compute; i++)
        glbk__restore_range(ctx, GLBK_GL_SHADER_STORAGE_BUFFER, i, s->storage[i], s->storage_ranges[i]);
    ctx->gl.BindBuffer(GLBK_GL_UNIFORM_BUFFER, (uint32_t)s->words[GLBK__W_BLOCK]);
    if (!ctx->compute) return;
    ctx->gl.BindBuffer(GLBK_GL_SHADER_STORAGE_BUFFER, (uint32_t)s->words[GLBK__W_STORAGE]);
    ctx->gl.BindBuffer(GLBK_GL_DISPATCH_INDIRECT_BUFFER, (uint32_t)s->words[GLBK__W_GROUPS]);
    glbk__restore_images(ctx, s);
}

static void glbk__depth_range(const glbk_context *ctx, float from, float to)
{
    if (ctx->es) ctx->gl.DepthRangef(from, to);
    else ctx->gl.DepthRange((double)from, (double)to);
}

GLBK_DEF void glbk_state_restore(glbk_context *ctx, const glbk_state *state)
{
    const int32_t *w;
    int i;
    if (!ctx || ctx->lost || !state) return;
    w = state->words;
    for (i = 0; i < GLBK__CAP_COUNT; i++)
        if (glbk__has_cap(ctx, i)) glbk__set_cap(ctx, glbk__caps[i].name, state->caps[i]);
    /* A program that its owner deleted while it was in use went away with the first glUseProgram. */
    ctx->gl.UseProgram(ctx->gl.IsProgram((uint32_t)w[GLBK__W_PROGRAM]) ? (uint32_t)w[GLBK__W_PROGRAM] : 0);
    ctx->gl.BindVertexArray((uint32_t)w[GLBK__W_VERTEX_ARRAY]);
    ctx->gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, (uint32_t)w[GLBK__W_TARGET]);
    ctx->gl.DepthFunc((uint32_t)w[GLBK__W_DEPTH_FUNC]);
    ctx->gl.CullFace((uint32_t)w[GLBK__W_CULL_MODE]);
    ctx->gl.FrontFace((uint32_t)w[GLBK__W_FRONT]);
    ctx->gl.BlendFuncSeparate((uint32_t)w[GLBK__W_SOURCE_RGB], (uint32_t)w[GLBK__W_DEST_RGB],
                              (uint32_t)w[GLBK__W_SOURCE_ALPHA], (uint32_t)w[GLBK__W_DEST_ALPHA]);
    ctx->gl.BlendEquationSeparate((uint32_t)w[GLBK__W_EQUATION_RGB], (uint32_t)w[GLBK__W_EQUATION_ALPHA]);
    if (ctx->clip_control) ctx->gl.ClipControl((uint32_t)w[GLBK__W_ORIGIN], (uint32_t)w[GLBK__W_CLIP_DEPTH]);
    if (!ctx->es) ctx->gl.PolygonMode(GLBK__FRONT_AND_BACK, (uint32_t)w[GLBK__W_POLYGON]);
    ctx->gl.Viewport(state->viewport[0], state->viewport[1], state->viewport[2], state->viewport[3]);
    ctx->gl.DepthMask(state->depth_mask);
    glbk__depth_range(ctx, state->floats[0], state->floats[1]);
    if (ctx->offset_clamp)
        ctx->gl.PolygonOffsetClamp(state->floats[2], state->floats[3], state->offset_clamp);
    else
        ctx->gl.PolygonOffset(state->floats[2], state->floats[3]);
    glbk__restore_indexed(ctx, state);
    glbk__restore_bindings(ctx, state);
}
