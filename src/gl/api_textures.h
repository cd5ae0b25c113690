/* ---- textures ---- */

typedef enum glbk_format {          /* both dialects know them all */
    GLBK_FORMAT_NONE,
    GLBK_FORMAT_COLOR,              /* RGBA32F; RGBA32UI with the bits of floats without ctx->float_targets */
    GLBK_FORMAT_R8, GLBK_FORMAT_RGBA8, GLBK_FORMAT_SRGB8_A8, GLBK_FORMAT_R8UI, GLBK_FORMAT_RGBA8UI,
    GLBK_FORMAT_R16UI, GLBK_FORMAT_RG16UI, GLBK_FORMAT_RGBA16UI,
    GLBK_FORMAT_R32UI, GLBK_FORMAT_RG32UI, GLBK_FORMAT_RGBA32UI,
    GLBK_FORMAT_R16F, GLBK_FORMAT_RGBA16F, GLBK_FORMAT_R32F, GLBK_FORMAT_RG32F, GLBK_FORMAT_RGBA32F,
    GLBK_FORMAT_DEPTH24, GLBK_FORMAT_DEPTH32F,
    GLBK_FORMAT_COUNT
} glbk_format;

typedef enum glbk_sampling {
    GLBK_SAMPLING_DEFAULT,          /* = GLBK_SAMPLING_NEAREST */
    GLBK_SAMPLING_NEAREST,
    GLBK_SAMPLING_LINEAR,           /* not for integers; 32-bit floats need ctx->float_linear */
    GLBK_SAMPLING_MIPMAPS,          /* linear, and between levels; they are generated on creation from data,
                                       those of floats where ctx->float_targets */
    GLBK_SAMPLING_COMPARE,          /* depth formats: linear comparison, sampler2DShadow */
    GLBK_SAMPLING_COUNT
} glbk_sampling;

typedef struct glbk_texture_desc {
    glbk_format   format;           /* required; GLBK_FORMAT_COLOR = GLBK_FORMAT_RGBA32F or RGBA32UI, see
                                       above */
    uint32_t      width, height;    /* 1 .. ctx->max_side */
    uint32_t      layers;           /* 0 = a 2D texture; else an array texture, 1 .. ctx->max_layers */
    uint32_t      levels;           /* 0 = 1, or all with GLBK_SAMPLING_MIPMAPS; at most down to 1 x 1 */
    glbk_sampling sampling;
    int           repeat;           /* not 0: wraps round; else clamps to the edge */
    const void   *data;             /* level 0, rows and layers without padding, or NULL = undefined texels */
} glbk_texture_desc;

typedef struct glbk_texture {       /* read only; zeroed = none */
    uint32_t    name;               /* GL's, for your own calls */
    uint32_t    gl_target;          /* GLBK_GL_TEXTURE_2D or GLBK_GL_TEXTURE_2D_ARRAY */
    glbk_format format;             /* GLBK_FORMAT_COLOR is resolved */
    uint32_t    width, height, layers, levels;
} glbk_texture;

GLBK_DEF glbk_result glbk_texture_create(glbk_context *ctx, const glbk_texture_desc *desc, glbk_texture *out);
/* Makes a texture with its sampling, and fills level 0 if desc.data is given. Mipmaps of a float format need
   ctx->float_targets.
   out      is zeroed on errors; free it with glbk_texture_free
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL; GLBK_ERR_DESC: a field is out of range; GLBK_ERR_LIMIT,
            for a size above ctx->max_side or max_layers;
            GLBK_ERR_FLOAT_TARGET, for mipmaps; GLBK_ERR_GL_MEMORY, GLBK_ERR_PENDING, GLBK_ERR_GL,
            GLBK_ERR_LOST. Every function below that creates, compiles or reads may return these last four;
            the other functions return GLBK_ERR_LOST alone of them, but all four if desc.check is set */

typedef struct glbk_box {           /* texels of one level of a texture */
    uint32_t level;
    uint32_t x, y;                  /* from the level's lower left corner on */
    uint32_t layer;                 /* the first one; 0 for a 2D texture */
    uint32_t width, height;         /* texels of that level */
    uint32_t layers;                /* 0 = 1 */
} glbk_box;

GLBK_DEF glbk_result glbk_texture_update(glbk_context *ctx, const glbk_texture *texture, const glbk_box *box,
                                         const void *data);
/* Overwrites a box of texels; other levels stay as they are, mipmaps too.
   box      must lie within the texture
   data     texels in the texture's format, rows and layers without padding; read during the call
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the box does not lie within the texture; GLBK_ERR_LOST */

GLBK_DEF void glbk_texture_free(glbk_context *ctx, glbk_texture *texture);
/* Deletes a texture and zeroes it. NULL and zeroed ones are allowed, here and in the other _free
   functions. */

/* ---- buffers: uniform blocks, vertices, and storage where ctx->compute ---- */

typedef struct glbk_buffer {        /* read only; zeroed = none */
    uint32_t name;
    size_t   bytes;
} glbk_buffer;

GLBK_DEF glbk_result glbk_buffer_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out);
/* Makes a buffer for any purpose but indices. It may serve several purposes, one after another.
   bytes    1 or more
   data     so many bytes, or NULL: the buffer's bytes are undefined then
   out      is zeroed on errors; free it with glbk_buffer_free
   Errors   GLBK_ERR_ARGUMENT: ctx or out is NULL, or bytes is 0; GLBK_ERR_LIMIT, for more bytes than
            PTRDIFF_MAX */

GLBK_DEF glbk_result glbk_indices_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out);
/* Makes a buffer for indices alone, as glbk_buffer_create does: WebGL allows indices in no buffer that was
   bound to anything else first. */

GLBK_DEF glbk_result glbk_buffer_update(glbk_context *ctx, const glbk_buffer *buffer, size_t offset,
                                        size_t bytes, const void *data);
/* Overwrites `bytes` bytes from byte `offset` on; the run must lie within the buffer. A whole buffer in one
   call costs least: it gets new storage, so that nothing waits for draws from the old.
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the run does not lie within the buffer; GLBK_ERR_LOST */

GLBK_DEF glbk_result glbk_buffer_read(glbk_context *ctx, const glbk_buffer *buffer, size_t offset,
                                      size_t bytes, void *out);
/* Copies `bytes` bytes from byte `offset` on to out; the run must lie within the buffer. The call waits until
   the GPU has done all its work, so the call is for tests and tools, not for frames.
   Errors   GLBK_ERR_ARGUMENT: as glbk_buffer_update; GLBK_ERR_FEATURE on ES and WebGL, which cannot read
            buffers */

GLBK_DEF void glbk_buffer_free(glbk_context *ctx, glbk_buffer *buffer);
/* Deletes a buffer and zeroes the struct. NULL and zeroed ones are allowed. */
