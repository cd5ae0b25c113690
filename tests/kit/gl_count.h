/* gl_count.h - counts calls of GL: all that a frame makes, and of them those that ask for something, which make
   browsers and drivers with threads of their own wait. Include gl_backend.h before. */
#ifndef GL_COUNT_H
#define GL_COUNT_H

static struct {
    glbk_functions real;
    int on, calls, asks, errors;    /* asks: glGet, glIs; errors: those of them that are glGetError */
    int uploads, data;              /* into textures; into buffers */
    int allowed;                    /* asks that a pass may make; see gl_state.h */
    int draws, others;
} gl_counted;

/* X(name, parameters, arguments, what it counts as besides) */
#define GL_COUNTED(X)                                                                                               \
    X(GetIntegerv, (uint32_t a, int32_t *b), (a, b), asks)                                                          \
    X(GetFloatv, (uint32_t a, float *b), (a, b), asks)                                                              \
    X(GetBooleanv, (uint32_t a, uint8_t *b), (a, b), asks)                                                          \
    X(GetIntegeri_v, (uint32_t a, uint32_t b, int32_t *c), (a, b, c), asks)                                         \
    X(GetInteger64i_v, (uint32_t a, uint32_t b, int64_t *c), (a, b, c), asks)                                       \
    X(GetBooleani_v, (uint32_t a, uint32_t b, uint8_t *c), (a, b, c), asks)                                         \
    X(GetShaderiv, (uint32_t a, uint32_t b, int32_t *c), (a, b, c), asks)                                           \
    X(GetProgramiv, (uint32_t a, uint32_t b, int32_t *c), (a, b, c), asks)                                          \
    X(GetBufferSubData, (uint32_t a, ptrdiff_t b, ptrdiff_t c, void *d), (a, b, c, d), asks)                        \
    X(ReadPixels, (int32_t a, int32_t b, int32_t c, int32_t d, uint32_t e, uint32_t f, void *g),                    \
      (a, b, c, d, e, f, g), asks)                                                                                  \
    X(Finish, (void), (), asks)                                                                                     \
    X(TexSubImage2D, (uint32_t a, int32_t b, int32_t c, int32_t d, int32_t e, int32_t f, uint32_t g, uint32_t h,    \
                      const void *i), (a, b, c, d, e, f, g, h, i), uploads)                                         \
    X(TexSubImage3D, (uint32_t a, int32_t b, int32_t c, int32_t d, int32_t e, int32_t f, int32_t g, int32_t h,      \
                      uint32_t i, uint32_t j, const void *k), (a, b, c, d, e, f, g, h, i, j, k), uploads)           \
    X(BufferData, (uint32_t a, ptrdiff_t b, const void *c, uint32_t d), (a, b, c, d), data)                         \
    X(BufferSubData, (uint32_t a, ptrdiff_t b, ptrdiff_t c, const void *d), (a, b, c, d), data)                     \
    X(DrawArrays, (uint32_t a, int32_t b, int32_t c), (a, b, c), draws)                                             \
    X(DrawElements, (uint32_t a, int32_t b, uint32_t c, const void *d), (a, b, c, d), draws)                        \
    X(DrawArraysInstanced, (uint32_t a, int32_t b, int32_t c, int32_t d), (a, b, c, d), draws)                      \
    X(DrawElementsInstanced, (uint32_t a, int32_t b, uint32_t c, const void *d, int32_t e), (a, b, c, d, e), draws) \
    X(DispatchCompute, (uint32_t a, uint32_t b, uint32_t c), (a, b, c), draws)                                      \
    X(DispatchComputeIndirect, (ptrdiff_t a), (a), draws)                                                           \
    X(Enable, (uint32_t a), (a), others)                                                                            \
    X(Disable, (uint32_t a), (a), others)                                                                           \
    X(Viewport, (int32_t a, int32_t b, int32_t c, int32_t d), (a, b, c, d), others)                                 \
    X(ColorMask, (uint8_t a, uint8_t b, uint8_t c, uint8_t d), (a, b, c, d), others)                                \
    X(DepthMask, (uint8_t a), (a), others)                                                                          \
    X(DepthFunc, (uint32_t a), (a), others)                                                                         \
    X(CullFace, (uint32_t a), (a), others)                                                                          \
    X(FrontFace, (uint32_t a), (a), others)                                                                         \
    X(DepthRange, (double a, double b), (a, b), others)                                                             \
    X(DepthRangef, (float a, float b), (a, b), others)                                                              \
    X(PolygonMode, (uint32_t a, uint32_t b), (a, b), others)                                                        \
    X(ClipControl, (uint32_t a, uint32_t b), (a, b), others)                                                        \
    X(ClearBufferfv, (uint32_t a, int32_t b, const float *c), (a, b, c), others)                                    \
    X(ClearBufferuiv, (uint32_t a, int32_t b, const uint32_t *c), (a, b, c), others)                                \
    X(PixelStorei, (uint32_t a, int32_t b), (a, b), others)                                                         \
    X(ActiveTexture, (uint32_t a), (a), others)                                                                     \
    X(BindTexture, (uint32_t a, uint32_t b), (a, b), others)                                                        \
    X(BindSampler, (uint32_t a, uint32_t b), (a, b), others)                                                        \
    X(BindBuffer, (uint32_t a, uint32_t b), (a, b), others)                                                         \
    X(BindBufferBase, (uint32_t a, uint32_t b, uint32_t c), (a, b, c), others)                                      \
    X(BindFramebuffer, (uint32_t a, uint32_t b), (a, b), others)                                                    \
    X(BindVertexArray, (uint32_t a), (a), others)                                                                   \
    X(UseProgram, (uint32_t a), (a), others)                                                                        \
    X(TexParameteri, (uint32_t a, uint32_t b, int32_t c), (a, b, c), others)                                        \
    X(FramebufferTextureLayer, (uint32_t a, uint32_t b, uint32_t c, int32_t d, int32_t e), (a, b, c, d, e), others) \
    X(BindImageTexture, (uint32_t a, uint32_t b, int32_t c, uint8_t d, int32_t e, uint32_t f, uint32_t g),          \
      (a, b, c, d, e, f, g), others)                                                                                \
    X(Barrier, (uint32_t a), (a), others)

#define GL_COUNT_CALL(name, parameters, arguments, kind)            \
    static inline void GLBK_CALL gl_count_##name parameters         \
    {                                                               \
        gl_counted.calls++;                                         \
        gl_counted.kind++;                                          \
        gl_counted.real.name arguments;                             \
    }
GL_COUNTED(GL_COUNT_CALL)

static inline uint32_t GLBK_CALL gl_count_error(void)
{
    gl_counted.calls++;
    gl_counted.asks++;
    gl_counted.errors++;
    return gl_counted.real.GetError();
}

static inline uint8_t GLBK_CALL gl_count_enabled(uint32_t name)
{
    gl_counted.calls++;
    gl_counted.asks++;
    return gl_counted.real.IsEnabled(name);
}

static inline void gl_count_reset(void)
{
    gl_counted.calls = gl_counted.asks = gl_counted.errors = gl_counted.uploads = gl_counted.data = 0;
    gl_counted.draws = gl_counted.others = 0;
}

/* Until gl_count_end. Functions that the context has not stay NULL. */
static inline void gl_count_begin(glbk_context *ctx)
{
    gl_counted.real = ctx->gl;
#define GL_COUNT_THIS(name, parameters, arguments, kind) \
    if (ctx->gl.name) ctx->gl.name = gl_count_##name;
    GL_COUNTED(GL_COUNT_THIS)
    ctx->gl.GetError = gl_count_error;
    ctx->gl.IsEnabled = gl_count_enabled;
    gl_counted.on = 1;
    gl_counted.allowed = 0;
    gl_count_reset();
}

static inline void gl_count_end(glbk_context *ctx)
{
    ctx->gl = gl_counted.real;
    gl_counted.on = 0;
}

#endif
