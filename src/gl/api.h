/* ---- the context ---- */

typedef void (*glbk_proc_fn)(void);
typedef glbk_proc_fn (*glbk_get_proc_fn)(const char *name, void *user);
/* Returns GL's function of that full name ("glBindTexture") or NULL. */

typedef struct glbk_allocator {     /* all zero = malloc and free; else both functions */
    void *(*alloc_fn)(size_t bytes, void *user);    /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} glbk_allocator;

typedef struct glbk_system {        /* all zero: malloc and free, no log */
    glbk_allocator allocator;       /* called from the thread that called us */
    void (*log)(void *user, const char *message);
    /* Called by a call that fails, from the thread that called us, before it returns: a text without a line
       end at its end that names the function, the field, its value and its range, or holds the driver's
       words, which may have several lines. It must call nothing of this library. */
    void *user;                     /* given to log */
} glbk_system;

typedef struct glbk_desc {
    glbk_system    system;
    glbk_get_proc_fn get_proc_fn;   /* required */
    void          *user;            /* handed to get_proc_fn */
    int            core_only;       /* not 0: what 3.3 and ES 3.0 share, even where the context has more */
    uint32_t       first_unit;      /* texture units first_unit .. + 15 are ours while we draw, and those
                                       further on, below + GLBK_MAX_UNITS, that a glbk_offset names */
    uint32_t       first_block;     /* likewise bindings of uniform blocks, first_block .. + 7, below +
                                       GLBK_MAX_BLOCKS; storage buffers and images, of compute alone, are
                                       always at 0 .. 7, as GLSL says their numbers */
    int            check;           /* not 0: calls of a frame ask for GL's error flag, too, and glbk_check
                                       and the glbk_..._resolve for the framebuffer; slow, to look for
                                       errors */
} glbk_desc;                        /* zero it, then set what you care about */

typedef struct glbk_context {
    glbk_functions gl;              /* gl.BindTexture(...): yours to call, too */
    const char    *renderer;        /* the driver's, valid while the context lives */
    int            es;              /* OpenGL ES or WebGL */
    int            webgl;           /* primitives always restart there: nothing to switch or to save */
    uint32_t       version;         /* 330 .. 460, or 300 .. 320 with es */
    int            compute;         /* OpenGL 4.3: compute shaders and storage buffers */
    int            float_targets;   /* RGBA32F and the like are renderable */
    int            float_blend;     /* ... and can be blended into */
    int            float_linear;    /* 32-bit float textures can be filtered */
    int            clip_control;
    uint32_t       max_side;        /* texels a side of a 2D texture */
    uint32_t       max_layers;      /* of an array texture */
    uint32_t       max_targets;     /* colour attachments that can be drawn to at once */
    float          max_point_side;  /* pixels */
    /* The rest is private. */
    uint32_t       vertex_array;    /* empty, for passes that need no attributes */
    uint32_t       shown;           /* buffer of the block glbk_shown of gl_gbuffer.h */
    int            lost;            /* calls no GL any more */
    glbk_system    system;
    uint32_t       first_unit, first_block;
    uint32_t       unit_count, block_count;     /* that there are from those on, at most GLBK_MAX_UNITS,
                                                   _BLOCKS */
    int            each_target;     /* colour mask and blending are switched for each target */
    int            each_blend;      /* ... and have functions of their own */
    int            offset_clamp;
    int            check;           /* desc.check */
    uint32_t       inner;           /* the framebuffer that glbk_begin bound last, if it is a technique's */
    size_t         max_storage;     /* bytes of a storage buffer */
} glbk_context;

#define GLBK_UNITS 16u              /* slots of textures, of uniform blocks, of storage buffers */
#define GLBK_BLOCKS 8u
#define GLBK_IMAGES 8u              /* slots of images, for compute */
#define GLBK_MAX_UNITS 32u          /* with offsets, where the context has as many; a shader stage has 16 */
#define GLBK_MAX_BLOCKS 16u

GLBK_DEF glbk_result glbk_init(glbk_context *ctx, const glbk_desc *desc);
/* Loads GL's functions from the context that is current, decides what it can do, and makes one empty vertex
   array and one small buffer.
   ctx      is yours, may be moved in memory afterwards, and is zeroed on errors
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC; GLBK_ERR_CONTEXT; GLBK_ERR_OLD_CONTEXT; GLBK_ERR_FUNCTION, its
            name in the log; GLBK_ERR_LIMIT where first_unit or first_block reach beyond what the context has;
            GLBK_ERR_PENDING, GLBK_ERR_LOST, GLBK_ERR_GL, GLBK_ERR_GL_MEMORY */

GLBK_DEF void glbk_free(glbk_context *ctx);
/* Deletes what glbk_init made and zeroes ctx, which may be NULL. Free textures, buffers, targets and programs
   before: afterwards their _free functions call no GL. */

GLBK_DEF void glbk_abandon(glbk_context *ctx);
/* Says that the GL context is gone or not current: from now on the _free functions touch memory only, and all
   other calls return GLBK_ERR_LOST or do nothing. ctx may be NULL. */

GLBK_DEF glbk_result glbk_check(glbk_context *ctx);
/* Takes GL's error flag and returns it as a result, with its number in the log: GLBK_OK, GLBK_ERR_GL,
   GLBK_ERR_GL_MEMORY, or GLBK_ERR_LOST, which no call of a frame notices by itself. Passes and updates do not
   ask for the flag (unless desc.check is set), so call this once a frame; it makes drivers with threads of
   their own wait for what was asked of them. With desc.check it returns GLBK_ERR_ORDER while a technique's
   framebuffer is bound: what you drew since that technique's passes went into it. After such passes bind your
   own framebuffer, or put glbk_state_save and glbk_state_restore round them. */

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
/* Makes a texture with its sampling, and fills level 0 where desc.data is given; of a float format its
   mipmaps need ctx->float_targets.
   out      is zeroed on errors; free it with glbk_texture_free
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC; GLBK_ERR_LIMIT, for a size above ctx->max_side or max_layers;
            GLBK_ERR_FLOAT_TARGET, for mipmaps; GLBK_ERR_GL_MEMORY, GLBK_ERR_PENDING, GLBK_ERR_GL,
            GLBK_ERR_LOST. These last four hold for every function below that creates, compiles or reads; of
            the others GLBK_ERR_LOST alone does, and all four with desc.check */

GLBK_DEF glbk_result glbk_texture_update(glbk_context *ctx, const glbk_texture *texture, uint32_t level,
                                         uint32_t x, uint32_t y, uint32_t layer, uint32_t width,
                                         uint32_t height, uint32_t layers, const void *data);
/* Overwrites a box of texels of one level; other levels stay as they are, mipmaps too.
   x .. height      texels of that level, from its lower left corner on; the box must lie within it
   layer, layers    the first layer and how many; 0 and 1 for a 2D texture
   data             texels in the texture's format, rows and layers without padding; read during the call
   Errors           GLBK_ERR_ARGUMENT; GLBK_ERR_LOST */

GLBK_DEF void glbk_texture_free(glbk_context *ctx, glbk_texture *texture);
/* Deletes a texture and zeroes it. NULL and zeroed ones are allowed, here and in the other _free
   functions. */

/* ---- buffers: uniform blocks, vertices, and storage where ctx->compute ---- */

typedef struct glbk_buffer {        /* read only; zeroed = none */
    uint32_t name;
    size_t   bytes;
} glbk_buffer;

GLBK_DEF glbk_result glbk_buffer_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out);
/* Makes a buffer for any purpose, one after another too, but for indices.
   bytes    1 or more
   data     so many bytes, or NULL: the buffer's bytes are undefined then
   out      is zeroed on errors; free it with glbk_buffer_free
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_LIMIT, for more bytes than PTRDIFF_MAX */

GLBK_DEF glbk_result glbk_indices_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out);
/* Makes a buffer for indices alone, as glbk_buffer_create does: WebGL allows indices in no buffer that was
   bound to anything else first. */

GLBK_DEF glbk_result glbk_buffer_update(glbk_context *ctx, const glbk_buffer *buffer, size_t offset,
                                        size_t bytes, const void *data);
/* Overwrites `bytes` bytes from byte `offset` on; the run must lie within the buffer. A whole buffer in one
   call costs least: it gets new storage, so that nothing waits for draws from the old.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_LOST */

GLBK_DEF glbk_result glbk_buffer_read(glbk_context *ctx, const glbk_buffer *buffer, size_t offset,
                                      size_t bytes, void *out);
/* Copies `bytes` bytes from byte `offset` on to out; the run must lie within the buffer. It waits until the
   GPU has done all that was asked of it before, so it is for tests and tools, not for frames.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_FEATURE on ES and WebGL, which cannot read buffers */

GLBK_DEF void glbk_buffer_free(glbk_context *ctx, glbk_buffer *buffer);

/* ---- targets ---- */

#define GLBK_MAX_ATTACHMENTS 4u     /* both dialects guarantee 4 */

typedef struct glbk_target_desc {
    const glbk_texture *color[GLBK_MAX_ATTACHMENTS];    /* from 0 on without gaps; all of one size */
    uint32_t            layer[GLBK_MAX_ATTACHMENTS];    /* of array textures */
    const glbk_texture *depth;      /* or NULL */
    uint32_t            depth_layer;
    uint32_t            level;      /* of all textures */
} glbk_target_desc;

typedef struct glbk_target {        /* read only; zeroed = none. The textures must outlive it */
    uint32_t    name;
    uint32_t    width, height, count;
    glbk_format format[GLBK_MAX_ATTACHMENTS];
    int         has_depth;
    int         inner;              /* private: a technique's */
} glbk_target;

GLBK_DEF glbk_result glbk_target_create(glbk_context *ctx, const glbk_target_desc *desc, glbk_target *out);
/* Makes a framebuffer of textures that you made. They must outlive it.
   out      is zeroed on errors; free it with glbk_target_free
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, where there is no attachment, or a layer or level that a texture
            has not; GLBK_ERR_MISMATCH, where sizes differ or a depth texture stands for colours;
            GLBK_ERR_FLOAT_TARGET, for floats without ctx->float_targets; GLBK_ERR_TARGET, where the driver
            cannot draw to this combination */

GLBK_DEF glbk_result glbk_target_read(glbk_context *ctx, const glbk_target *target, uint32_t attachment,
                                      uint32_t x, uint32_t y, uint32_t width, uint32_t height, void *rgba);
/* Copies width x height pixels of a colour attachment from the GPU, from pixel (x, y) on, rows from the
   bottom up. It waits until the GPU has done all that was asked of it before.
   attachment   0 .. target->count - 1
   rgba         receives 16 bytes a pixel: four floats, or four uint32_t where the format has integers. Of a
                GLBK_FORMAT_COLOR target these are the floats in either case
   Errors       GLBK_ERR_ARGUMENT, also where the pixels do not lie within the target */

GLBK_DEF void glbk_target_free(glbk_context *ctx, glbk_target *target);
