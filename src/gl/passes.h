/* ---- passes: what is drawn to, by which program, from which textures and buffers ---- */

enum {
    GLBK__LESS = 0x0201, GLBK__EQUAL = 0x0202, GLBK__GREATER = 0x0204, GLBK__ALWAYS = 0x0207,
    GLBK__FUNC_ADD = 0x8006, GLBK__MIN = 0x8007, GLBK__MAX = 0x8008, GLBK__ONE = 1,
    GLBK__SRC_ALPHA = 0x0302, GLBK__ONE_MINUS_SRC_ALPHA = 0x0303,
    GLBK__FRONT = 0x0404, GLBK__BACK = 0x0405, GLBK__CCW = 0x0901, GLBK__READ_WRITE = 0x88BA
};

static void glbk__set_depth(const glbk_context *ctx, glbk_depth depth)
{
    static const uint32_t functions[] = { GLBK__ALWAYS, GLBK__LESS, GLBK__LEQUAL, GLBK__EQUAL,
                                          GLBK__GREATER };
    glbk__set_cap(ctx, GLBK__DEPTH_TEST, depth != GLBK_DEPTH_OFF);
    ctx->gl.DepthMask(depth != GLBK_DEPTH_OFF && depth != GLBK_DEPTH_EQUAL);
    ctx->gl.DepthFunc(functions[depth]);
}

static void glbk__set_blend(const glbk_context *ctx, glbk_blend blend)
{
    static const uint32_t equations[] = { GLBK__FUNC_ADD, GLBK__FUNC_ADD, GLBK__MIN, GLBK__MAX,
                                          GLBK__FUNC_ADD };
    if (blend == GLBK_BLEND_OFF) return;
    ctx->gl.Enable(GLBK__BLEND);
    ctx->gl.BlendEquationSeparate(equations[blend], equations[blend]);
    if (blend == GLBK_BLEND_OVER)
        ctx->gl.BlendFuncSeparate(GLBK__SRC_ALPHA, GLBK__ONE_MINUS_SRC_ALPHA, GLBK__ONE,
                                  GLBK__ONE_MINUS_SRC_ALPHA);
    else ctx->gl.BlendFuncSeparate(GLBK__ONE, GLBK__ONE, GLBK__ONE, GLBK__ONE);
}

static void glbk__set_cull(const glbk_context *ctx, glbk_cull cull)
{
    ctx->gl.FrontFace(GLBK__CCW);
    if (cull == GLBK_CULL_OFF) return;
    ctx->gl.Enable(GLBK__CULL_FACE);
    ctx->gl.CullFace(cull == GLBK_CULL_BACK ? GLBK__BACK : GLBK__FRONT);
}

static int glbk__has_srgb(const glbk_target *target)
{
    uint32_t i;
    for (i = 0; target && i < target->count; i++)
        if (target->format[i] == GLBK_FORMAT_SRGB8_A8) return 1;
    return 0;
}

static glbk_result glbk__check_pass(const glbk_context *ctx, const glbk_pass *pass)
{
    static const char function[] = "glbk_begin";
    const int32_t *v = pass->viewport;
    if ((unsigned)pass->depth >= GLBK_DEPTH_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "pass.depth", (double)pass->depth,
                                  "a glbk_depth");
    if ((unsigned)pass->blend >= GLBK_BLEND_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "pass.blend", (double)pass->blend,
                                  "a glbk_blend");
    if ((unsigned)pass->cull >= GLBK_CULL_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "pass.cull", (double)pass->cull,
                                  "a glbk_cull");
    if (pass->target && !pass->target->name)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "pass.target", "was not created");
    if (v[2] < 0 || v[3] < 0)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function,
                                  v[2] < 0 ? "pass.viewport[2]" : "pass.viewport[3]", v[2] < 0 ? v[2] : v[3],
                                  "0 or more");
    if (!pass->target && (!v[2] || !v[3]))
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, v[2] ? "pass.viewport[3]" : "pass.viewport[2]",
                            "is 0, and there is no pass.target whose size it could be");
    return GLBK_OK;
}

GLBK_DEF void glbk_program_use(glbk_context *ctx, glbk_program *program)
{
    if (!ctx || ctx->lost || !program) return;
    ctx->gl.UseProgram(program->name);
    ctx->program = program->name;
    if (program->slots_fn) program->slots_fn(ctx, program);
    program->slots_fn = NULL;
}

GLBK_DEF glbk_result glbk_begin(glbk_context *ctx, const glbk_pass *pass, glbk_program *program)
{
    const int32_t *v;
    glbk_result result;
    uint8_t color;
    int i;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!pass) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "pass", "is NULL");
    result = glbk__check_pass(ctx, pass);
    if (result != GLBK_OK) return result;
    if (ctx->lost) return GLBK_ERR_LOST;
    v = pass->viewport;

    for (i = 0; i < GLBK__CAP_COUNT; i++)
        if (glbk__has_cap(ctx, i) && (glbk__caps[i].group != GLBK__CAP_SRGB || glbk__has_srgb(pass->target)))
            glbk__set_cap(ctx, glbk__caps[i].name, glbk__caps[i].value);
    if (pass->target) {
        ctx->gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, pass->target->name);
        ctx->inner = pass->target->inner ? pass->target->name : 0;
    }
    if (v[2] || v[3]) ctx->gl.Viewport(v[0], v[1], v[2], v[3]);
    else ctx->gl.Viewport(0, 0, (int32_t)pass->target->width, (int32_t)pass->target->height);
    glbk__set_depth(ctx, pass->depth);
    glbk__set_blend(ctx, pass->blend);
    glbk__set_cull(ctx, pass->cull);
    color = !pass->no_color;
    ctx->gl.ColorMask(color, color, color, color);
    glbk__depth_range(ctx, 0, 1);
    if (pass->offset[0] != 0 || pass->offset[1] != 0) {
        ctx->gl.Enable(GLBK__POLYGON_OFFSET_FILL);
        ctx->gl.PolygonOffset(pass->offset[0], pass->offset[1]);
    }
    if (!ctx->es) ctx->gl.PolygonMode(GLBK__FRONT_AND_BACK, GLBK__FILL);
    if (ctx->clip_control) ctx->gl.ClipControl(GLBK__LOWER_LEFT, GLBK__NEGATIVE_ONE_TO_ONE);
    ctx->gl.BindVertexArray(ctx->vertex_array);
    glbk_program_use(ctx, program);
    return GLBK_OK;
}

GLBK_DEF void glbk_clear(glbk_context *ctx, const glbk_target *target, uint32_t attachment,
                         const float rgba[4])
{
    if (!ctx || ctx->lost || !target || attachment >= target->count || !rgba) return;
    if (glbk__is_integer(target->format[attachment])) {
        uint32_t words[4];
        int i;
        if (target->format[attachment] == GLBK_FORMAT_RGBA32UI && !ctx->float_targets) {
            memcpy(words, rgba, sizeof words);      /* the bits of the floats */
        } else {
            for (i = 0; i < 4; i++)
                words[i] = rgba[i] > 0
                               ? (uint32_t)(rgba[i] < 4294967296.0f ? (double)rgba[i] + 0.5 : 4294967295.0)
                               : 0;
        }
        ctx->gl.ClearBufferuiv(GLBK_GL_COLOR, (int32_t)attachment, words);
    } else {
        ctx->gl.ClearBufferfv(GLBK_GL_COLOR, (int32_t)attachment, rgba);
    }
}

GLBK_DEF void glbk_clear_depth(glbk_context *ctx, float depth)
{
    if (ctx && !ctx->lost) ctx->gl.ClearBufferfv(GLBK_GL_DEPTH, 0, &depth);
}

GLBK_DEF void glbk_bind_texture(glbk_context *ctx, uint32_t slot, const glbk_texture *texture)
{
    if (!ctx || ctx->lost || slot >= ctx->unit_count) return;
    ctx->gl.ActiveTexture(GLBK_GL_TEXTURE0 + ctx->first_unit + slot);
    if (texture && texture->name) {
        ctx->gl.BindTexture(texture->gl_target, texture->name);
    } else {
        ctx->gl.BindTexture(GLBK_GL_TEXTURE_2D, 0);
        ctx->gl.BindTexture(GLBK_GL_TEXTURE_2D_ARRAY, 0);
    }
    ctx->gl.BindSampler(ctx->first_unit + slot, 0);
}

GLBK_DEF void glbk_bind_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer)
{
    if (!ctx || ctx->lost || !buffer || slot >= ctx->block_count) return;
    ctx->gl.BindBufferBase(GLBK_GL_UNIFORM_BUFFER, ctx->first_block + slot, buffer->name);
}

GLBK_DEF void glbk_bind_storage(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer)
{
    if (!ctx || ctx->lost || !ctx->compute || !buffer || slot >= GLBK_BLOCKS) return;
    ctx->gl.BindBufferBase(GLBK_GL_SHADER_STORAGE_BUFFER, slot, buffer->name);
}

GLBK_DEF void glbk_bind_image(glbk_context *ctx, uint32_t slot, const glbk_texture *texture)
{
    if (!ctx || ctx->lost || !ctx->compute || !texture || !texture->name || slot >= GLBK_IMAGES) return;
    ctx->gl.BindImageTexture(slot, texture->name, 0, texture->layers != 0, 0, GLBK__READ_WRITE,
                             (uint32_t)glbk__formats[texture->format].internal);
}

GLBK_DEF void glbk_draw_screen(glbk_context *ctx)
{
    if (ctx && !ctx->lost) ctx->gl.DrawArrays(GLBK_GL_TRIANGLES, 0, 3);
}
