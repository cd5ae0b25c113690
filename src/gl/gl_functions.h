/* ---- results ---- */

#define GLBK_RESULTS(X)                                                                                     \
    X(GLBK_OK, "ok")                                                                                        \
    X(GLBK_ERR_ARGUMENT, "a pointer is NULL, or a count or stride is out of range")                         \
    X(GLBK_ERR_DESC, "a field of a desc is out of range")                                                   \
    X(GLBK_ERR_INPUT, "the data cannot be used")                                                            \
    X(GLBK_ERR_ALLOC, "the allocator returned no memory")                                                   \
    X(GLBK_ERR_MEMORY, "the caller's memory is too small or misaligned")                                    \
    X(GLBK_ERR_LIMIT, "a size overflows or passes a limit")                                                 \
    X(GLBK_ERR_CANCELLED, "cancelled by the progress callback")                                             \
    X(GLBK_ERR_ORDER, "this call comes too early, too late or twice")                                       \
    X(GLBK_ERR_FORMAT, "not a file of this kind, or a damaged one")                                         \
    X(GLBK_ERR_VERSION, "a file of an unknown version")                                                     \
    X(GLBK_ERR_MISMATCH, "what was given does not belong together")                                         \
    X(GLBK_ERR_CONTEXT, "no GL context is current")                                                         \
    X(GLBK_ERR_OLD_CONTEXT, "the context is older than OpenGL 3.3 or OpenGL ES 3.0")                        \
    X(GLBK_ERR_FUNCTION, "a GL function is missing")                                                        \
    X(GLBK_ERR_FEATURE, "this call needs OpenGL 4.3 (compute)")                                             \
    X(GLBK_ERR_FLOAT_TARGET, "rendering to this float format needs EXT_color_buffer_float")                 \
    X(GLBK_ERR_NAME, "no GLSL file of that name")                                                           \
    X(GLBK_ERR_COMPILE, "a shader does not compile")                                                        \
    X(GLBK_ERR_LINK, "a program does not link")                                                             \
    X(GLBK_ERR_TARGET, "the driver cannot render to this combination of formats")                           \
    X(GLBK_ERR_GL_MEMORY, "GL is out of memory")                                                            \
    X(GLBK_ERR_GL, "GL reported an error")                                                                  \
    X(GLBK_ERR_PENDING, "a GL error from before this call was pending")                                     \
    X(GLBK_ERR_LOST, "the GL context is lost")

typedef enum glbk_result {
#define GLBK__ENUM(name, text) name,
    GLBK_RESULTS(GLBK__ENUM)
#undef GLBK__ENUM
    GLBK_RESULT_COUNT
} glbk_result;

GLBK_DEF const char *glbk_result_text(glbk_result result);
/* A constant string for any value, "unknown result" beyond the list. */

/* ---- GL itself: functions without the gl prefix, constants ----

   X(group, return type, name, parameters). Groups: CORE is in OpenGL 3.3 and ES 3.0 alike; DESK in OpenGL 3.3 only, ES
   in ES only; the others from the version on that they name, NULL where the context is older. */

#define GLBK_FUNCTIONS(X)                                                                                            \
    X(CORE, const uint8_t *, GetString, (uint32_t name))                                                             \
    X(CORE, const uint8_t *, GetStringi, (uint32_t name, uint32_t index))                                            \
    X(CORE, uint32_t, GetError, (void))                                                                              \
    X(CORE, void, GetIntegerv, (uint32_t name, int32_t *out))                                                        \
    X(CORE, void, GetFloatv, (uint32_t name, float *out))                                                            \
    X(CORE, void, GetBooleanv, (uint32_t name, uint8_t *out))                                                        \
    X(CORE, void, GetIntegeri_v, (uint32_t name, uint32_t index, int32_t *out))                                      \
    X(CORE, void, GetInteger64i_v, (uint32_t name, uint32_t index, int64_t *out))                                    \
    X(CORE, uint8_t, IsEnabled, (uint32_t cap))                                                                      \
    X(CORE, void, Enable, (uint32_t cap))                                                                            \
    X(CORE, void, Disable, (uint32_t cap))                                                                           \
    X(CORE, void, Viewport, (int32_t x, int32_t y, int32_t width, int32_t height))                                   \
    X(CORE, void, Scissor, (int32_t x, int32_t y, int32_t width, int32_t height))                                    \
    X(CORE, void, ColorMask, (uint8_t r, uint8_t g, uint8_t b, uint8_t a))                                           \
    X(CORE, void, DepthMask, (uint8_t on))                                                                           \
    X(CORE, void, DepthFunc, (uint32_t func))                                                                        \
    X(CORE, void, CullFace, (uint32_t face))                                                                         \
    X(CORE, void, FrontFace, (uint32_t order))                                                                       \
    X(CORE, void, PolygonOffset, (float factor, float units))                                                        \
    X(CORE, void, BlendEquationSeparate, (uint32_t rgb, uint32_t alpha))                                             \
    X(CORE, void, BlendFuncSeparate, (uint32_t srgb, uint32_t drgb, uint32_t salpha, uint32_t dalpha))               \
    X(CORE, void, ClearBufferfv, (uint32_t buffer, int32_t index, const float *value))                               \
    X(CORE, void, ClearBufferuiv, (uint32_t buffer, int32_t index, const uint32_t *value))                           \
    X(CORE, void, PixelStorei, (uint32_t name, int32_t value))                                                       \
    X(CORE, void, ReadPixels, (int32_t x, int32_t y, int32_t width, int32_t height, uint32_t format, uint32_t type,  \
                               void *out))                                                                           \
    X(CORE, void, ActiveTexture, (uint32_t unit))                                                                    \
    X(CORE, void, GenTextures, (int32_t count, uint32_t *names))                                                     \
    X(CORE, void, DeleteTextures, (int32_t count, const uint32_t *names))                                            \
    X(CORE, void, BindTexture, (uint32_t target, uint32_t name))                                                     \
    X(CORE, void, BindSampler, (uint32_t unit, uint32_t name))                                                       \
    X(CORE, void, TexParameteri, (uint32_t target, uint32_t name, int32_t value))                                    \
    X(CORE, void, GenerateMipmap, (uint32_t target))                                                                 \
    X(CORE, void, TexImage2D, (uint32_t target, int32_t level, int32_t internal, int32_t width, int32_t height,      \
                               int32_t border, uint32_t format, uint32_t type, const void *data))                    \
    X(CORE, void, TexImage3D, (uint32_t target, int32_t level, int32_t internal, int32_t width, int32_t height,      \
                               int32_t depth, int32_t border, uint32_t format, uint32_t type, const void *data))     \
    X(CORE, void, TexSubImage2D, (uint32_t target, int32_t level, int32_t x, int32_t y, int32_t width,               \
                                  int32_t height, uint32_t format, uint32_t type, const void *data))                 \
    X(CORE, void, TexSubImage3D, (uint32_t target, int32_t level, int32_t x, int32_t y, int32_t z, int32_t width,    \
                                  int32_t height, int32_t depth, uint32_t format, uint32_t type, const void *data))  \
    X(CORE, void, GenFramebuffers, (int32_t count, uint32_t *names))                                                 \
    X(CORE, void, DeleteFramebuffers, (int32_t count, const uint32_t *names))                                        \
    X(CORE, void, BindFramebuffer, (uint32_t target, uint32_t name))                                                 \
    X(CORE, void, FramebufferTexture2D, (uint32_t target, uint32_t attachment, uint32_t textarget, uint32_t texture, \
                                         int32_t level))                                                             \
    X(CORE, void, FramebufferTextureLayer, (uint32_t target, uint32_t attachment, uint32_t texture, int32_t level,   \
                                            int32_t layer))                                                          \
    X(CORE, uint32_t, CheckFramebufferStatus, (uint32_t target))                                                     \
    X(CORE, void, DrawBuffers, (int32_t count, const uint32_t *buffers))                                             \
    X(CORE, void, ReadBuffer, (uint32_t source))                                                                     \
    X(CORE, void, GenBuffers, (int32_t count, uint32_t *names))                                                      \
    X(CORE, void, DeleteBuffers, (int32_t count, const uint32_t *names))                                             \
    X(CORE, void, BindBuffer, (uint32_t target, uint32_t name))                                                      \
    X(CORE, void, BindBufferBase, (uint32_t target, uint32_t index, uint32_t name))                                  \
    X(CORE, void, BindBufferRange, (uint32_t target, uint32_t index, uint32_t name, ptrdiff_t offset,                \
                                    ptrdiff_t size))                                                                 \
    X(CORE, void, BufferData, (uint32_t target, ptrdiff_t size, const void *data, uint32_t usage))                   \
    X(CORE, void, BufferSubData, (uint32_t target, ptrdiff_t offset, ptrdiff_t size, const void *data))              \
    X(CORE, void, GenVertexArrays, (int32_t count, uint32_t *names))                                                 \
    X(CORE, void, DeleteVertexArrays, (int32_t count, const uint32_t *names))                                        \
    X(CORE, void, BindVertexArray, (uint32_t name))                                                                  \
    X(CORE, void, EnableVertexAttribArray, (uint32_t index))                                                         \
    X(CORE, void, VertexAttribPointer, (uint32_t index, int32_t size, uint32_t type, uint8_t normalized,             \
                                        int32_t stride, const void *offset))                                         \
    X(CORE, void, DrawArrays, (uint32_t mode, int32_t first, int32_t count))                                         \
    X(CORE, void, DrawElements, (uint32_t mode, int32_t count, uint32_t type, const void *offset))                   \
    X(CORE, void, DrawArraysInstanced, (uint32_t mode, int32_t first, int32_t count, int32_t instances))             \
    X(CORE, void, DrawElementsInstanced, (uint32_t mode, int32_t count, uint32_t type, const void *offset,           \
                                          int32_t instances))                                                        \
    X(CORE, uint32_t, CreateShader, (uint32_t type))                                                                 \
    X(CORE, void, ShaderSource, (uint32_t shader, int32_t count, const char *const *texts, const int32_t *lengths))  \
    X(CORE, void, CompileShader, (uint32_t shader))                                                                  \
    X(CORE, void, GetShaderiv, (uint32_t shader, uint32_t name, int32_t *out))                                       \
    X(CORE, void, GetShaderInfoLog, (uint32_t shader, int32_t size, int32_t *length, char *log))                     \
    X(CORE, void, DeleteShader, (uint32_t shader))                                                                   \
    X(CORE, uint32_t, CreateProgram, (void))                                                                         \
    X(CORE, void, AttachShader, (uint32_t program, uint32_t shader))                                                 \
    X(CORE, void, TransformFeedbackVaryings, (uint32_t program, int32_t count, const char *const *names,             \
                                              uint32_t mode))                                                        \
    X(CORE, void, LinkProgram, (uint32_t program))                                                                   \
    X(CORE, void, GetProgramiv, (uint32_t program, uint32_t name, int32_t *out))                                     \
    X(CORE, void, GetProgramInfoLog, (uint32_t program, int32_t size, int32_t *length, char *log))                   \
    X(CORE, void, DeleteProgram, (uint32_t program))                                                                 \
    X(CORE, uint8_t, IsProgram, (uint32_t program))                                                                  \
    X(CORE, void, UseProgram, (uint32_t program))                                                                    \
    X(CORE, int32_t, GetUniformLocation, (uint32_t program, const char *name))                                       \
    X(CORE, uint32_t, GetUniformBlockIndex, (uint32_t program, const char *name))                                    \
    X(CORE, void, UniformBlockBinding, (uint32_t program, uint32_t index, uint32_t binding))                         \
    X(CORE, void, Uniform1i, (int32_t location, int32_t x))                                                          \
    X(CORE, void, Uniform1f, (int32_t location, float x))                                                            \
    X(CORE, void, Uniform4fv, (int32_t location, int32_t count, const float *values))                                \
    X(CORE, void, UniformMatrix4fv, (int32_t location, int32_t count, uint8_t transpose, const float *values))       \
    X(CORE, void, BeginTransformFeedback, (uint32_t mode))                                                           \
    X(CORE, void, EndTransformFeedback, (void))                                                                      \
    X(CORE, void, Finish, (void))                                                                                    \
    X(ES, void, DepthRangef, (float from, float to))                                                                 \
    X(ES, void, TexStorage2D, (uint32_t target, int32_t levels, uint32_t format, int32_t width, int32_t height))     \
    X(ES, void, TexStorage3D, (uint32_t target, int32_t levels, uint32_t format, int32_t width, int32_t height,      \
                               int32_t depth))                                                                       \
    X(DESK, void, DepthRange, (double from, double to))                                                              \
    X(DESK, void, PolygonMode, (uint32_t face, uint32_t mode))                                                       \
    X(DESK, void, PointSize, (float size))                                                                           \
    X(DESK, void, ClampColor, (uint32_t target, uint32_t clamp))                                                     \
    X(TARGETS, void, ColorMaski, (uint32_t index, uint8_t r, uint8_t g, uint8_t b, uint8_t a)) /* 3.3, ES 3.2 */     \
    X(TARGETS, void, GetBooleani_v, (uint32_t name, uint32_t index, uint8_t *out))                                   \
    X(TARGETS, void, Enablei, (uint32_t cap, uint32_t index))                                                        \
    X(TARGETS, void, Disablei, (uint32_t cap, uint32_t index))                                                       \
    X(TARGETS, uint8_t, IsEnabledi, (uint32_t cap, uint32_t index))                                                  \
    X(BLENDS, void, BlendEquationSeparatei, (uint32_t index, uint32_t rgb, uint32_t alpha)) /* 4.0, ES 3.2 */        \
    X(BLENDS, void, BlendFuncSeparatei, (uint32_t index, uint32_t srgb, uint32_t drgb, uint32_t salpha,              \
                                         uint32_t dalpha))                                                           \
    X(DESK, void, GetBufferSubData, (uint32_t target, ptrdiff_t offset, ptrdiff_t size, void *out))                  \
    X(COMPUTE, void, DispatchCompute, (uint32_t x, uint32_t y, uint32_t z))                                          \
    X(COMPUTE, void, DispatchComputeIndirect, (ptrdiff_t offset))                                                    \
    X(COMPUTE, void, BindImageTexture, (uint32_t unit, uint32_t texture, int32_t level, uint8_t layered,             \
                                        int32_t layer, uint32_t access, uint32_t format))                            \
    X(COMPUTE, void, Barrier, (uint32_t bits)) /* glMemoryBarrier: windows.h has a macro of that name */              \
    X(CLIP, void, ClipControl, (uint32_t origin, uint32_t depth)) /* 4.5 or an extension, of ES too */                \
    X(CLAMP, void, PolygonOffsetClamp, (float factor, float units, float clamp)) /* 4.6 or an extension */

typedef struct glbk_functions {
#define GLBK__FIELD(group, type, name, parameters) type(GLBK_CALL *name) parameters;
    GLBK_FUNCTIONS(GLBK__FIELD)
#undef GLBK__FIELD
} glbk_functions;

/* What the sections below and most users need of GL's constants. */
#define GLBK_GL_TRIANGLES 0x0004u
#define GLBK_GL_TRIANGLE_STRIP 0x0005u
#define GLBK_GL_POINTS 0x0000u
#define GLBK_GL_LINES 0x0001u
#define GLBK_GL_BYTE 0x1400u
#define GLBK_GL_UNSIGNED_BYTE 0x1401u
#define GLBK_GL_UNSIGNED_SHORT 0x1403u
#define GLBK_GL_INT 0x1404u
#define GLBK_GL_UNSIGNED_INT 0x1405u
#define GLBK_GL_FLOAT 0x1406u
#define GLBK_GL_HALF_FLOAT 0x140Bu
#define GLBK_GL_COLOR 0x1800u
#define GLBK_GL_DEPTH 0x1801u
#define GLBK_GL_TEXTURE_2D 0x0DE1u
#define GLBK_GL_TEXTURE_2D_ARRAY 0x8C1Au
#define GLBK_GL_TEXTURE0 0x84C0u
#define GLBK_GL_FRAMEBUFFER 0x8D40u
#define GLBK_GL_READ_FRAMEBUFFER 0x8CA8u
#define GLBK_GL_DRAW_FRAMEBUFFER 0x8CA9u
#define GLBK_GL_COLOR_ATTACHMENT0 0x8CE0u
#define GLBK_GL_DEPTH_ATTACHMENT 0x8D00u
#define GLBK_GL_ARRAY_BUFFER 0x8892u
#define GLBK_GL_ELEMENT_ARRAY_BUFFER 0x8893u
#define GLBK_GL_UNIFORM_BUFFER 0x8A11u
#define GLBK_GL_SHADER_STORAGE_BUFFER 0x90D2u
#define GLBK_GL_COPY_WRITE_BUFFER 0x8F37u
#define GLBK_GL_TRANSFORM_FEEDBACK_BUFFER 0x8C8Eu
#define GLBK_GL_INTERLEAVED_ATTRIBS 0x8C8Cu
#define GLBK_GL_RASTERIZER_DISCARD 0x8C89u
#define GLBK_GL_STATIC_DRAW 0x88E4u
#define GLBK_GL_STREAM_DRAW 0x88E0u
#define GLBK_GL_ANY_SAMPLES_PASSED 0x8C2Fu
#define GLBK_GL_QUERY_RESULT 0x8866u
#define GLBK_GL_ALL_BARRIER_BITS 0xFFFFFFFFu
