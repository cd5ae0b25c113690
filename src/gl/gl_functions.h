/* ---- GL itself: functions without the gl prefix, constants ----

   X(group, return type, name, types of the parameters, in the order that GL's reference gives them). Groups:
   CORE is in OpenGL 3.3 and ES 3.0 alike; DESK in OpenGL 3.3 only, ES in ES only; TARGETS in OpenGL 3.3 and
   ES 3.2, BLENDS in OpenGL 4.0 and ES 3.2, COMPUTE in OpenGL 4.3: NULL where the context is older. */

#define GLBK__QUERY_FUNCTIONS(X) \
    X(CORE, const uint8_t *, GetString, (uint32_t)) \
    X(CORE, const uint8_t *, GetStringi, (uint32_t, uint32_t)) X(CORE, uint32_t, GetError, (void)) \
    X(CORE, void, GetIntegerv, (uint32_t, int32_t *)) X(CORE, void, GetFloatv, (uint32_t, float *)) \
    X(CORE, void, GetBooleanv, (uint32_t, uint8_t *)) \
    X(CORE, void, GetIntegeri_v, (uint32_t, uint32_t, int32_t *)) \
    X(CORE, void, GetInteger64i_v, (uint32_t, uint32_t, int64_t *)) \
    X(CORE, uint8_t, IsEnabled, (uint32_t))
#define GLBK__STATE_FUNCTIONS(X) \
    X(CORE, void, Enable, (uint32_t)) X(CORE, void, Disable, (uint32_t)) \
    X(CORE, void, Viewport, (int32_t, int32_t, int32_t, int32_t)) \
    X(CORE, void, Scissor, (int32_t, int32_t, int32_t, int32_t)) \
    X(CORE, void, ColorMask, (uint8_t, uint8_t, uint8_t, uint8_t)) X(CORE, void, DepthMask, (uint8_t)) \
    X(CORE, void, DepthFunc, (uint32_t)) X(CORE, void, CullFace, (uint32_t)) \
    X(CORE, void, FrontFace, (uint32_t)) X(CORE, void, PolygonOffset, (float, float)) \
    X(CORE, void, BlendEquationSeparate, (uint32_t, uint32_t)) \
    X(CORE, void, BlendFuncSeparate, (uint32_t, uint32_t, uint32_t, uint32_t))
#define GLBK__CLEAR_FUNCTIONS(X) \
    X(CORE, void, ClearBufferfv, (uint32_t, int32_t, const float *)) \
    X(CORE, void, ClearBufferuiv, (uint32_t, int32_t, const uint32_t *)) \
    X(CORE, void, PixelStorei, (uint32_t, int32_t)) \
    X(CORE, void, ReadPixels, (int32_t, int32_t, int32_t, int32_t, uint32_t, uint32_t, void *))
#define GLBK__TEXTURE_FUNCTIONS(X) \
    X(CORE, void, ActiveTexture, (uint32_t)) X(CORE, void, GenTextures, (int32_t, uint32_t *)) \
    X(CORE, void, DeleteTextures, (int32_t, const uint32_t *)) \
    X(CORE, void, BindTexture, (uint32_t, uint32_t)) X(CORE, void, BindSampler, (uint32_t, uint32_t)) \
    X(CORE, void, TexParameteri, (uint32_t, uint32_t, int32_t)) X(CORE, void, GenerateMipmap, (uint32_t))
#define GLBK__IMAGE_FUNCTIONS(X) \
    X(CORE, void, TexImage2D, (uint32_t, int32_t, int32_t, int32_t, int32_t, int32_t, uint32_t, \
                               uint32_t, const void *)) \
    X(CORE, void, TexImage3D, (uint32_t, int32_t, int32_t, int32_t, int32_t, int32_t, int32_t, \
                               uint32_t, uint32_t, const void *)) \
    X(CORE, void, TexSubImage2D, (uint32_t, int32_t, int32_t, int32_t, int32_t, int32_t, uint32_t, \
                                  uint32_t, const void *)) \
    X(CORE, void, TexSubImage3D, (uint32_t, int32_t, int32_t, int32_t, int32_t, int32_t, int32_t, \
                                  int32_t, uint32_t, uint32_t, const void *))
#define GLBK__TARGET_FUNCTIONS(X) \
    X(CORE, void, GenFramebuffers, (int32_t, uint32_t *)) \
    X(CORE, void, DeleteFramebuffers, (int32_t, const uint32_t *)) \
    X(CORE, void, BindFramebuffer, (uint32_t, uint32_t)) \
    X(CORE, void, FramebufferTexture2D, (uint32_t, uint32_t, uint32_t, uint32_t, int32_t)) \
    X(CORE, void, FramebufferTextureLayer, (uint32_t, uint32_t, uint32_t, int32_t, int32_t)) \
    X(CORE, uint32_t, CheckFramebufferStatus, (uint32_t)) \
    X(CORE, void, DrawBuffers, (int32_t, const uint32_t *)) X(CORE, void, ReadBuffer, (uint32_t))
#define GLBK__BUFFER_FUNCTIONS(X) \
    X(CORE, void, GenBuffers, (int32_t, uint32_t *)) \
    X(CORE, void, DeleteBuffers, (int32_t, const uint32_t *)) \
    X(CORE, void, BindBuffer, (uint32_t, uint32_t)) \
    X(CORE, void, BindBufferBase, (uint32_t, uint32_t, uint32_t)) \
    X(CORE, void, BindBufferRange, (uint32_t, uint32_t, uint32_t, ptrdiff_t, ptrdiff_t)) \
    X(CORE, void, BufferData, (uint32_t, ptrdiff_t, const void *, uint32_t)) \
    X(CORE, void, BufferSubData, (uint32_t, ptrdiff_t, ptrdiff_t, const void *)) \
    X(CORE, void, GenVertexArrays, (int32_t, uint32_t *)) \
    X(CORE, void, DeleteVertexArrays, (int32_t, const uint32_t *))
#define GLBK__DRAW_FUNCTIONS(X) \
    X(CORE, void, BindVertexArray, (uint32_t)) X(CORE, void, EnableVertexAttribArray, (uint32_t)) \
    X(CORE, void, VertexAttribPointer, (uint32_t, int32_t, uint32_t, uint8_t, int32_t, const void *)) \
    X(CORE, void, DrawArrays, (uint32_t, int32_t, int32_t)) \
    X(CORE, void, DrawElements, (uint32_t, int32_t, uint32_t, const void *)) \
    X(CORE, void, DrawArraysInstanced, (uint32_t, int32_t, int32_t, int32_t)) \
    X(CORE, void, DrawElementsInstanced, (uint32_t, int32_t, uint32_t, const void *, int32_t))
#define GLBK__SHADER_FUNCTIONS(X) \
    X(CORE, uint32_t, CreateShader, (uint32_t)) \
    X(CORE, void, ShaderSource, (uint32_t, int32_t, const char *const *, const int32_t *)) \
    X(CORE, void, CompileShader, (uint32_t)) X(CORE, void, GetShaderiv, (uint32_t, uint32_t, int32_t *)) \
    X(CORE, void, GetShaderInfoLog, (uint32_t, int32_t, int32_t *, char *)) \
    X(CORE, void, DeleteShader, (uint32_t))
#define GLBK__PROGRAM_FUNCTIONS(X) \
    X(CORE, uint32_t, CreateProgram, (void)) X(CORE, void, AttachShader, (uint32_t, uint32_t)) \
    X(CORE, void, TransformFeedbackVaryings, (uint32_t, int32_t, const char *const *, uint32_t)) \
    X(CORE, void, LinkProgram, (uint32_t)) X(CORE, void, GetProgramiv, (uint32_t, uint32_t, int32_t *)) \
    X(CORE, void, GetProgramInfoLog, (uint32_t, int32_t, int32_t *, char *)) \
    X(CORE, void, DeleteProgram, (uint32_t)) X(CORE, uint8_t, IsProgram, (uint32_t)) \
    X(CORE, void, UseProgram, (uint32_t))
#define GLBK__UNIFORM_FUNCTIONS(X) \
    X(CORE, int32_t, GetUniformLocation, (uint32_t, const char *)) \
    X(CORE, uint32_t, GetUniformBlockIndex, (uint32_t, const char *)) \
    X(CORE, void, UniformBlockBinding, (uint32_t, uint32_t, uint32_t)) \
    X(CORE, void, GetActiveUniform, (uint32_t, uint32_t, int32_t, int32_t *, int32_t *, uint32_t *, char *)) \
    X(CORE, void, GetActiveUniformBlockName, (uint32_t, uint32_t, int32_t, int32_t *, char *)) \
    X(CORE, void, GetActiveUniformBlockiv, (uint32_t, uint32_t, uint32_t, int32_t *)) \
    X(CORE, void, GetUniformiv, (uint32_t, int32_t, int32_t *)) \
    X(CORE, void, Uniform1i, (int32_t, int32_t)) X(CORE, void, Uniform1f, (int32_t, float)) \
    X(CORE, void, Uniform4fv, (int32_t, int32_t, const float *)) \
    X(CORE, void, UniformMatrix4fv, (int32_t, int32_t, uint8_t, const float *))
#define GLBK__FEEDBACK_FUNCTIONS(X) \
    X(CORE, void, BeginTransformFeedback, (uint32_t)) X(CORE, void, EndTransformFeedback, (void)) \
    X(CORE, void, Finish, (void))
#define GLBK__ONE_DIALECT_FUNCTIONS(X) \
    X(ES, void, DepthRangef, (float, float)) \
    X(ES, void, TexStorage2D, (uint32_t, int32_t, uint32_t, int32_t, int32_t)) \
    X(ES, void, TexStorage3D, (uint32_t, int32_t, uint32_t, int32_t, int32_t, int32_t)) \
    X(DESK, void, DepthRange, (double, double)) X(DESK, void, PolygonMode, (uint32_t, uint32_t)) \
    X(DESK, void, PointSize, (float)) X(DESK, void, ClampColor, (uint32_t, uint32_t))
#define GLBK__LATER_FUNCTIONS(X) \
    X(TARGETS, void, ColorMaski, (uint32_t, uint8_t, uint8_t, uint8_t, uint8_t)) \
    X(TARGETS, void, GetBooleani_v, (uint32_t, uint32_t, uint8_t *)) \
    X(TARGETS, void, Enablei, (uint32_t, uint32_t)) X(TARGETS, void, Disablei, (uint32_t, uint32_t)) \
    X(TARGETS, uint8_t, IsEnabledi, (uint32_t, uint32_t)) \
    X(BLENDS, void, BlendEquationSeparatei, (uint32_t, uint32_t, uint32_t)) \
    X(BLENDS, void, BlendFuncSeparatei, (uint32_t, uint32_t, uint32_t, uint32_t, uint32_t)) \
    X(DESK, void, GetBufferSubData, (uint32_t, ptrdiff_t, ptrdiff_t, void *))
#define GLBK__COMPUTE_FUNCTIONS(X) \
    X(COMPUTE, void, DispatchCompute, (uint32_t, uint32_t, uint32_t)) \
    X(COMPUTE, void, DispatchComputeIndirect, (ptrdiff_t)) \
    X(COMPUTE, uint32_t, GetProgramResourceIndex, (uint32_t, uint32_t, const char *)) \
    X(COMPUTE, void, BindImageTexture, (uint32_t, uint32_t, int32_t, uint8_t, int32_t, uint32_t, \
                                        uint32_t)) \
    X(COMPUTE, void, Barrier, (uint32_t)) /* glMemoryBarrier: windows.h has a macro of that name */ \
    X(CLIP, void, ClipControl, (uint32_t, uint32_t)) /* 4.5 or an extension, of ES too */ \
    X(CLAMP, void, PolygonOffsetClamp, (float, float, float)) /* 4.6 or an extension */
#define GLBK_FUNCTIONS(X) \
    GLBK__QUERY_FUNCTIONS(X) GLBK__STATE_FUNCTIONS(X) GLBK__CLEAR_FUNCTIONS(X) GLBK__TEXTURE_FUNCTIONS(X) \
    GLBK__IMAGE_FUNCTIONS(X) GLBK__TARGET_FUNCTIONS(X) GLBK__BUFFER_FUNCTIONS(X) GLBK__DRAW_FUNCTIONS(X) \
    GLBK__SHADER_FUNCTIONS(X) GLBK__PROGRAM_FUNCTIONS(X) GLBK__UNIFORM_FUNCTIONS(X) \
    GLBK__FEEDBACK_FUNCTIONS(X) GLBK__ONE_DIALECT_FUNCTIONS(X) GLBK__LATER_FUNCTIONS(X) \
    GLBK__COMPUTE_FUNCTIONS(X)

typedef struct glbk_functions {
#define GLBK__FIELD(group, type, name, parameters) type(GLBK_CALL *name) parameters;
    GLBK_FUNCTIONS(GLBK__FIELD)
#undef GLBK__FIELD
} glbk_functions;

/* The constants of GL that the sections below and most users need. */
enum {
    GLBK_GL_TRIANGLES = 0x0004, GLBK_GL_TRIANGLE_STRIP = 0x0005, GLBK_GL_POINTS = 0x0000,
    GLBK_GL_LINES = 0x0001, GLBK_GL_BYTE = 0x1400, GLBK_GL_UNSIGNED_BYTE = 0x1401,
    GLBK_GL_UNSIGNED_SHORT = 0x1403, GLBK_GL_INT = 0x1404, GLBK_GL_UNSIGNED_INT = 0x1405,
    GLBK_GL_FLOAT = 0x1406, GLBK_GL_HALF_FLOAT = 0x140B, GLBK_GL_COLOR = 0x1800, GLBK_GL_DEPTH = 0x1801,
    GLBK_GL_TEXTURE_2D = 0x0DE1, GLBK_GL_TEXTURE_2D_ARRAY = 0x8C1A,
    GLBK_GL_TEXTURE_CUBE_MAP = 0x8513, GLBK_GL_TEXTURE0 = 0x84C0,
    GLBK_GL_FRAMEBUFFER = 0x8D40, GLBK_GL_READ_FRAMEBUFFER = 0x8CA8, GLBK_GL_DRAW_FRAMEBUFFER = 0x8CA9,
    GLBK_GL_COLOR_ATTACHMENT0 = 0x8CE0, GLBK_GL_DEPTH_ATTACHMENT = 0x8D00, GLBK_GL_ARRAY_BUFFER = 0x8892,
    GLBK_GL_ELEMENT_ARRAY_BUFFER = 0x8893, GLBK_GL_UNIFORM_BUFFER = 0x8A11,
    GLBK_GL_SHADER_STORAGE_BUFFER = 0x90D2, GLBK_GL_COPY_WRITE_BUFFER = 0x8F37,
    GLBK_GL_TRANSFORM_FEEDBACK_BUFFER = 0x8C8E, GLBK_GL_INTERLEAVED_ATTRIBS = 0x8C8C,
    GLBK_GL_RASTERIZER_DISCARD = 0x8C89, GLBK_GL_STATIC_DRAW = 0x88E4, GLBK_GL_STREAM_DRAW = 0x88E0,
    GLBK_GL_ANY_SAMPLES_PASSED = 0x8C2F, GLBK_GL_QUERY_RESULT = 0x8866,
    GLBK_GL_DISPATCH_INDIRECT_BUFFER = 0x90EE
};
#define GLBK_GL_ALL_BARRIER_BITS 0xFFFFFFFFu
