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
    /* Called by a call that fails, from the thread that called us, before it returns: a text without a line end at its
       end that names the function, the field, its value and its range, or holds the driver's words, which may have
       several lines. It must call nothing of this library. */
    void *user;                     /* given to log */
} glbk_system;

typedef struct glbk_desc {
    glbk_system    system;
    glbk_get_proc_fn get_proc_fn;   /* required */
    void          *user;            /* handed to get_proc_fn */
    int            core_only;       /* not 0: what 3.3 and ES 3.0 share, even where the context has more */
    uint32_t       first_unit;      /* texture units first_unit .. + 15 are ours while we draw, and those further on,
                                       below + GLBK_MAX_UNITS, that a glbk_offset names */
    uint32_t       first_block;     /* likewise bindings of uniform blocks, first_block .. + 7, below + GLBK_MAX_BLOCKS;
                                       storage buffers and images, of compute alone, are always at 0 .. 7, as GLSL says
                                       their numbers */
    int            check;           /* not 0: calls of a frame ask for GL's error flag, too, and glbk_check and the
                                       glbk_..._resolve for the framebuffer; slow, to look for errors */
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
    uint32_t       shown;           /* buffer of the block glbk_shown */
    int            lost;            /* calls no GL any more */
    glbk_system    system;
    uint32_t       first_unit, first_block;
    uint32_t       unit_count, block_count;     /* that there are from those on, at most GLBK_MAX_UNITS, _BLOCKS */
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
/* Loads the functions, decides what the current context can do, makes one empty vertex array.
   ctx      yours; may be moved in memory; zeroed on errors
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC; GLBK_ERR_CONTEXT; GLBK_ERR_OLD_CONTEXT; GLBK_ERR_FUNCTION, its name in the
            log; GLBK_ERR_LIMIT where first_unit or first_block reach beyond what the context has; GLBK_ERR_PENDING,
            GLBK_ERR_LOST, GLBK_ERR_GL, GLBK_ERR_GL_MEMORY */

GLBK_DEF void glbk_free(glbk_context *ctx);
/* Deletes what glbk_init made and zeroes ctx. Destroy textures and the like before. Accepts NULL. */

GLBK_DEF void glbk_abandon(glbk_context *ctx);
/* The GL context is gone or not current: from now on destroying calls touch memory only, all others return
   GLBK_ERR_LOST. */

GLBK_DEF glbk_result glbk_check(glbk_context *ctx);
/* GL's error flag as a result, with its number in the log; once a frame, since passes and updates do not ask for it
   (unless desc.check is set). It is what notices a lost context.
   With desc.check it is GLBK_ERR_ORDER where a technique's framebuffer is still bound: what you drew since then went
   into that. After a technique's passes bind your own, or put glbk_state_save and glbk_state_restore round them. */

/* ---- textures ---- */

/* X(name, internal format, format, type, bytes a texel, components): formats that both dialects know. */
#define GLBK_FORMATS(X)                                             \
    X(GLBK_FORMAT_NONE, 0, 0, 0, 0, 0)                              \
    X(GLBK_FORMAT_COLOR, 0, 0, 0, 0, 4) /* RGBA32F, or its bits */  \
    X(GLBK_FORMAT_R8, 0x8229, 0x1903, 0x1401, 1, 1)                 \
    X(GLBK_FORMAT_RGBA8, 0x8058, 0x1908, 0x1401, 4, 4)              \
    X(GLBK_FORMAT_SRGB8_A8, 0x8C43, 0x1908, 0x1401, 4, 4)           \
    X(GLBK_FORMAT_R8UI, 0x8232, 0x8D94, 0x1401, 1, 1)               \
    X(GLBK_FORMAT_RGBA8UI, 0x8D7C, 0x8D99, 0x1401, 4, 4)            \
    X(GLBK_FORMAT_R16UI, 0x8234, 0x8D94, 0x1403, 2, 1)              \
    X(GLBK_FORMAT_RG16UI, 0x823A, 0x8228, 0x1403, 4, 2)             \
    X(GLBK_FORMAT_RGBA16UI, 0x8D76, 0x8D99, 0x1403, 8, 4)           \
    X(GLBK_FORMAT_R32UI, 0x8236, 0x8D94, 0x1405, 4, 1)              \
    X(GLBK_FORMAT_RG32UI, 0x823C, 0x8228, 0x1405, 8, 2)             \
    X(GLBK_FORMAT_RGBA32UI, 0x8D70, 0x8D99, 0x1405, 16, 4)          \
    X(GLBK_FORMAT_R16F, 0x822D, 0x1903, 0x140B, 2, 1)               \
    X(GLBK_FORMAT_RGBA16F, 0x881A, 0x1908, 0x140B, 8, 4)            \
    X(GLBK_FORMAT_R32F, 0x822E, 0x1903, 0x1406, 4, 1)               \
    X(GLBK_FORMAT_RG32F, 0x8230, 0x8227, 0x1406, 8, 2)              \
    X(GLBK_FORMAT_RGBA32F, 0x8814, 0x1908, 0x1406, 16, 4)           \
    X(GLBK_FORMAT_DEPTH24, 0x81A6, 0x1902, 0x1405, 4, 1)            \
    X(GLBK_FORMAT_DEPTH32F, 0x8CAC, 0x1902, 0x1406, 4, 1)

typedef enum glbk_format {
#define GLBK__ENUM(name, internal, format, type, bytes, components) name,
    GLBK_FORMATS(GLBK__ENUM)
#undef GLBK__ENUM
    GLBK_FORMAT_COUNT
} glbk_format;

typedef enum glbk_sampling {
    GLBK_SAMPLING_DEFAULT,          /* = GLBK_SAMPLING_NEAREST */
    GLBK_SAMPLING_NEAREST,
    GLBK_SAMPLING_LINEAR,           /* not for integers; 32-bit floats need ctx->float_linear */
    GLBK_SAMPLING_MIPMAPS,          /* linear, and between levels; they are generated on creation from data, those of
                                       floats where ctx->float_targets */
    GLBK_SAMPLING_COMPARE,          /* depth formats: linear comparison, sampler2DShadow */
    GLBK_SAMPLING_COUNT
} glbk_sampling;

typedef struct glbk_texture_desc {
    glbk_format   format;           /* required; GLBK_FORMAT_COLOR = GLBK_FORMAT_RGBA32F or RGBA32UI, see above */
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
/* Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC; GLBK_ERR_LIMIT; GLBK_ERR_FLOAT_TARGET, for mipmaps; GLBK_ERR_GL_MEMORY,
            GLBK_ERR_PENDING, GLBK_ERR_GL, GLBK_ERR_LOST: these four hold for every function below that creates,
            compiles or reads; of the others GLBK_ERR_LOST alone does, and all four with desc.check */

GLBK_DEF glbk_result glbk_texture_update(glbk_context *ctx, const glbk_texture *texture, uint32_t level, uint32_t x,
                                         uint32_t y, uint32_t layer, uint32_t width, uint32_t height,
                                         uint32_t layers, const void *data);
/* A box of texels, rows and layers without padding; layer 0 and layers 1 for a 2D texture. */

GLBK_DEF glbk_result glbk_table_create(glbk_context *ctx, glbk_format format, const void *texels, size_t count,
                                       glbk_texture *out);
/* An array texture that lib/table.glsl reads by one number: texel i stands at (i & 1023, i >> 10 & 1023, i >> 20).
   texels   count of them, 1 .. ctx->max_layers * 2^20, or NULL = undefined; any format but the depth formats
   Memory on the GPU: count rounded up to rows of 1024, above 2^20 texels to layers of 2^20.
   Errors   GLBK_ERR_LIMIT */

GLBK_DEF glbk_result glbk_table_update(glbk_context *ctx, const glbk_texture *table, size_t first, size_t count,
                                       const void *texels);

GLBK_DEF void glbk_texture_free(glbk_context *ctx, glbk_texture *texture);

/* ---- buffers: uniform blocks, vertices, and storage where ctx->compute ---- */

typedef struct glbk_buffer {        /* read only; zeroed = none */
    uint32_t name;
    size_t   bytes;
} glbk_buffer;

GLBK_DEF glbk_result glbk_buffer_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out);
/* bytes > 0; data NULL = undefined. For any purpose, one after another too, but indices. */
GLBK_DEF glbk_result glbk_indices_create(glbk_context *ctx, size_t bytes, const void *data, glbk_buffer *out);
/* The same for indices alone: WebGL allows them in no buffer that was bound to anything else first. */
GLBK_DEF glbk_result glbk_buffer_update(glbk_context *ctx, const glbk_buffer *buffer, size_t offset, size_t bytes,
                                        const void *data);
/* Of the whole buffer in one call is best: it gets new storage, so that nothing waits for draws from the old. */
GLBK_DEF glbk_result glbk_buffer_read(glbk_context *ctx, const glbk_buffer *buffer, size_t offset, size_t bytes,
                                      void *out);
/* Waits for the GPU. Not on ES and WebGL: GLBK_ERR_FEATURE. */
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
/* Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC (no attachment, a layer or level that a texture has not);
            GLBK_ERR_MISMATCH (sizes differ, a depth texture where colours go); GLBK_ERR_FLOAT_TARGET;
            GLBK_ERR_TARGET */

GLBK_DEF glbk_result glbk_target_read(glbk_context *ctx, const glbk_target *target, uint32_t attachment, uint32_t x,
                                      uint32_t y, uint32_t width, uint32_t height, void *rgba);
/* Pixels from the GPU, which is waited for: four 32-bit words each, floats, or integers where the format has integers
   (of a GLBK_FORMAT_COLOR target these are the floats in either case); rows from the bottom up. */

GLBK_DEF void glbk_target_free(glbk_context *ctx, glbk_target *target);

/* ---- GLSL and programs ---- */

typedef struct glbk_file {          /* one file of GLSL, as a header holds it */
    const char        *name;        /* "lib/table.glsl", "prog/copy.frag" */
    const char *const *texts;       /* without comments, and blanks that divide nothing; fit for glShaderSource */
    uint32_t           text_count;
    const char        *uses;        /* library files that go before it, by their bare names: "table csm_bindings" */
    const char        *with;        /* of a .frag: its vertex shader; else "" */
    const char        *sets;        /* the define sets that are tested, separated by " | " */
    const char        *block;       /* the uniform block that it declares, and nothing else; or "" */
} glbk_file;

typedef struct glbk_slot { const char *name; uint32_t slot; } glbk_slot;

/* The GLSL of one header. Each header has a function that returns its own: glbk_base_part for this one, glbk_csm_part
   for gl_csm.h and so on. Nothing is registered anywhere: a program is given the parts whose files it uses, and a
   linker leaves out the GLSL of all others. */
typedef struct glbk_part {
    const char      *name;          /* "csm" */
    const glbk_file *files;
    uint32_t         file_count;
    const glbk_slot *textures, *blocks;     /* each ends with an entry that has no name */
} glbk_part;

#define GLBK_MAX_PARTS 6u           /* that one program can use beside the base, which every program can */

GLBK_DEF const glbk_part *glbk_base_part(void);
GLBK_DEF const glbk_file *glbk_find_file(const glbk_part *part, const char *name);
/* A file of the part or of the base, NULL if there is none of this name ("lib/table.glsl"). Needs no context.
   part   NULL = the base's files alone */

typedef struct glbk_offset {        /* where the slots of a part begin in a program that uses several parts */
    uint32_t unit, block;           /* added to the slots of its textures and of its uniform blocks */
} glbk_offset;

typedef struct glbk_source {        /* a program of your own, with library files */
    const char *vertex;             /* main of the vertex shader as text; NULL = a triangle over the whole screen */
    const char *fragment;           /* main of the fragment shader as text, or NULL with compute */
    const char *compute;
    const char *uses;               /* library files by their bare names, in order, without what they use themselves;
                                       uniform blocks of the library that your text names are found */
    const char *defines;            /* "FILTER=1 FAST", or NULL; the vertex shader sees them too */
    const char *outputs;            /* names for transform feedback, separated by blanks, interleaved; or NULL */
    const glbk_part *parts[GLBK_MAX_PARTS];     /* whose files it uses: glbk_csm_part(), ...; NULLs are left out */
    glbk_offset offsets[GLBK_MAX_PARTS];        /* of the slots of each of these parts. What a technique's glbk_..._bind
                                       binds for this program needs the same offset */
} glbk_source;

typedef struct glbk_program {       /* read only; zeroed = none */
    uint32_t name;
    int      slots_set;             /* private */
    const glbk_part *parts[GLBK_MAX_PARTS];     /* private */
    glbk_offset offsets[GLBK_MAX_PARTS];        /* private */
} glbk_program;

GLBK_DEF glbk_result glbk_program_create(glbk_context *ctx, const glbk_part *part, const char *name,
                                         const char *defines, glbk_program *out);
/* A program of the library.
   part     that has it; NULL = the base
   name     of its last stage: "copy.frag", "csm_query.comp"
   defines  one of its sets, or NULL = none
   Errors   GLBK_ERR_NAME; GLBK_ERR_COMPILE, GLBK_ERR_LINK, the driver's words in the log, where line 2007 is line 7 of
            file 2, listed there too; GLBK_ERR_ALLOC; GLBK_ERR_FEATURE: .comp without ctx->compute */

GLBK_DEF glbk_result glbk_program_compile(glbk_context *ctx, const glbk_source *source, glbk_program *out);
/* Likewise from your text, which has no #version line: glbk writes it, and lib/prelude.glsl after it.
   Errors   as above; GLBK_ERR_MISMATCH where two samplers or two uniform blocks of the parts that the program declares
            have one texture unit or one binding, both in the log: give one part an offset; GLBK_ERR_LIMIT where an
            offset leads beyond GLBK_MAX_UNITS, GLBK_MAX_BLOCKS or what the context has from first_unit on */

typedef enum glbk_dialect {
    GLBK_GLSL_DEFAULT,              /* = GLBK_GLSL_330 */
    GLBK_GLSL_330,
    GLBK_GLSL_300_ES,
    GLBK_GLSL_430,
    GLBK_GLSL_COUNT
} glbk_dialect;

typedef struct glbk_shader {        /* one stage of a program */
    const char *uses, *defines;     /* as in glbk_source, or NULL */
    const char *name;               /* the file with its main ("prog/copy.frag", which brings its own uses), or NULL */
    const char *text;               /* your text, behind that file if both are given; or NULL */
    const glbk_part *parts[GLBK_MAX_PARTS];     /* as in glbk_source */
} glbk_shader;

GLBK_DEF size_t glbk_write_glsl(glbk_dialect dialect, int float_bits, const glbk_shader *shader, char *out,
                                size_t bytes);
/* The text that the two above give to the driver, for your own renderer. Needs no context.
   float_bits   GLBK_FORMAT_COLOR targets hold integers
   out          receives it, cut to so many bytes and ended by 0; may be NULL with bytes 0
   Returns the bytes needed with the 0, or 0 where a name is unknown or defines do not parse. */

GLBK_DEF void glbk_program_free(glbk_context *ctx, glbk_program *program);

GLBK_DEF void glbk_program_use(glbk_context *ctx, glbk_program *program);
/* glUseProgram, and at the first time its textures and blocks get their slots. */

enum { GLBK_SLOT_glbk_user0 = 12, GLBK_SLOT_glbk_user1, GLBK_SLOT_glbk_user2, GLBK_SLOT_glbk_user3 };

GLBK_DEF glbk_result glbk_set_slots(glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                    uint32_t gl_program);
/* The same for a program that you linked yourself, in use or not: every texture and block of the part's and the base's
   lists that it declares gets its slot, samplers of yours that are called glbk_user0 to glbk_user3 those above.
   Beside the functions for your own shaders these are free; not beside lib/ism_gbuffer.glsl and the programs of rsm and
   ism themselves: glbk_rsm_states, _coarse, _history and _before have 12 to 15, ism's G-buffer and light 11 to 15.
   part     NULL = the base alone
   offset   of the part's slots; NULL = none. The base's stay where they are
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_LIMIT, as glbk_program_compile says; GLBK_ERR_LOST. Nothing is set then */

/* ---- passes ---- */

typedef enum glbk_depth {
    GLBK_DEPTH_OFF,                 /* neither tested nor written */
    GLBK_DEPTH_LESS,
    GLBK_DEPTH_LESS_EQUAL,
    GLBK_DEPTH_EQUAL,               /* tested, not written */
    GLBK_DEPTH_GREATER,
    GLBK_DEPTH_COUNT
} glbk_depth;

typedef enum glbk_blend {
    GLBK_BLEND_OFF,
    GLBK_BLEND_ADD,
    GLBK_BLEND_MIN,
    GLBK_BLEND_MAX,
    GLBK_BLEND_OVER,                /* by source alpha */
    GLBK_BLEND_COUNT
} glbk_blend;

typedef enum glbk_cull { GLBK_CULL_OFF, GLBK_CULL_BACK, GLBK_CULL_FRONT, GLBK_CULL_COUNT } glbk_cull;

typedef struct glbk_pass {
    const glbk_target *target;      /* NULL = the framebuffer that is bound; then the viewport must be given, and
                                       FRAMEBUFFER_SRGB is as you have set it: no pass encodes colours by itself */
    int32_t            viewport[4]; /* x, y, width, height; all zero = the whole target */
    glbk_depth         depth;
    glbk_blend         blend;
    glbk_cull          cull;
    int                no_color;    /* not 0: writes depth only */
    float              offset[2];   /* of depth: factor and units of glPolygonOffset; both 0 = off */
} glbk_pass;                        /* all zero but the target: overwrite everything */

/* The techniques' glbk_..._resolve draw a picture one texel a pixel, its lower left corner at the viewport's. A smaller
   viewport cuts it off; a larger one, or a larger target without a viewport, is GLBK_ERR_DESC: nothing is scaled.
   To show a picture in another size, resolve to a target of its own size and draw that. */

typedef struct glbk_picture {       /* what glbk_..._resolve draws, beside what the pass says. NULL or all zero: every
                                       pixel, without depths */
    int          keep_empty;        /* not 0: where nothing is seen, nothing is drawn: what lies there stays */
    const float *world_to_clip;     /* 16 floats, OpenGL's clip space -1..1: depths are drawn too, those of what is
                                       seen, 1 where nothing is; pass.depth tests and writes them. They are recomputed
                                       from places, so they may differ in the last bits from those of a draw of the
                                       same surface. NULL: one depth, 0.5, for all */
} glbk_picture;
/* With desc.check, glbk_..._resolve without pass.target is GLBK_ERR_ORDER while the framebuffer that is bound is a
   technique's, see glbk_check. */

GLBK_DEF glbk_result glbk_begin(glbk_context *ctx, const glbk_pass *pass, glbk_program *program);
/* Sets every state that a draw depends on, so that nothing inherited shows; binds target and program and the empty
   vertex array. Bind textures and blocks after it. docs/gl-state.md lists what is touched.
   program  NULL where you use your own
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_DESC, GLBK_ERR_LOST; GL's error flag is not asked */

GLBK_DEF void glbk_clear(glbk_context *ctx, const glbk_target *target, uint32_t attachment, const float rgba[4]);
/* After glbk_begin to that target. Integer formats get the numbers, rounded, within 0 and 2^32 - 1; GLBK_FORMAT_COLOR
   the floats. */
GLBK_DEF void glbk_clear_depth(glbk_context *ctx, float depth);
/* After glbk_begin with a depth mode that writes. */

GLBK_DEF void glbk_bind_texture(glbk_context *ctx, uint32_t slot, const glbk_texture *texture);
/* To a slot of the lists (GLBK_SLOT_name), plus its part's offset, without a sampler object. Slots count from
   ctx->first_unit on, 16 and those that offsets name; bind textures of your own beyond them yourself. A slot beyond
   GLBK_MAX_UNITS or the context's last unit does nothing.
   texture   NULL or not created: the unit gets no texture, for a sampler that is declared and not read. What others
             left there may be of another kind than the sampler, and WebGL then refuses to draw. */
GLBK_DEF void glbk_bind_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer);
/* The whole buffer as uniform block. */
GLBK_DEF void glbk_bind_storage(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer);
/* The whole buffer as storage buffer; with ctx->compute only. */
GLBK_DEF void glbk_bind_image(glbk_context *ctx, uint32_t slot, const glbk_texture *texture);
/* Level 0, all layers, to read and to write from compute shaders; with ctx->compute only. Its format is the shader's
   layout: rgba32f for GLBK_FORMAT_COLOR. Not RG of 8 bits, not sRGB, not depth. */

GLBK_DEF void glbk_draw_screen(glbk_context *ctx);
/* One triangle over the whole viewport: after glbk_begin. */

GLBK_DEF glbk_result glbk_dispatch(glbk_context *ctx, glbk_program *program, uint32_t x, uint32_t y, uint32_t z);
/* Runs x * y * z groups of a compute program and makes what it wrote visible to everything after it.
   Errors   GLBK_ERR_FEATURE, GLBK_ERR_LOST */

GLBK_DEF glbk_result glbk_dispatch_indirect(glbk_context *ctx, glbk_program *program, const glbk_buffer *groups,
                                            size_t offset);
/* The same with x, y, z as three uint32_t at that byte of a buffer, which a shader may have written.
   offset   a multiple of 4
   Errors   GLBK_ERR_FEATURE, GLBK_ERR_LOST */

/* ---- state ---- */

typedef struct glbk_state {         /* private: what glbk_begin and the binding calls may change */
    uint8_t  caps[32], blend[8];
    uint8_t  color_mask[8][4], depth_mask;
    int32_t  words[24];
    int32_t  viewport[4];
    float    floats[4];
    int32_t  units[GLBK_MAX_UNITS][3];
    int32_t  blocks[GLBK_MAX_BLOCKS], storage[GLBK_BLOCKS];
    int64_t  ranges[GLBK_MAX_BLOCKS][2], storage_ranges[GLBK_BLOCKS][2];
    int32_t  images[GLBK_IMAGES][6];
    int32_t  blends[8][6];
    float    offset_clamp;
} glbk_state;

GLBK_DEF void glbk_state_save(glbk_context *ctx, glbk_state *out);
GLBK_DEF void glbk_state_restore(glbk_context *ctx, const glbk_state *state);
/* Round a pass or a whole frame of them, where the rest of your renderer relies on its state. What was bound must not
   be deleted in between; a program that you had deleted while it was in use is gone (0) afterwards, as GL says. */

/* ---- bindings ----

   Each part (this header, and each technique's) has four lists, empty where it needs none:

     GLBK_part_TEXTURES(X)   X(GLSL type, name, slot)
     GLBK_part_BLOCKS(X)     X(name, slot, MEMBERS), each with a list MEMBERS(X): X(GLSL type, name, count)
     GLBK_part_STORAGE(X)    X(qualifiers, GLSL type, name, slot), an array without size, for compute
     GLBK_part_IMAGES(X)     X(qualifiers, format, GLSL type, name, slot), for compute

   Slots of textures count from 0 to GLBK_UNITS - 1, those of blocks, storage and images to 7, anew in each part. A
   program that uses several parts gives each a glbk_offset, so that they do not meet; base being one too, whose slots
   stay. From the lists come GLBK_SLOT_name, the C struct of each block (std140:
   only mat4, vec4, ivec4, uvec4 and arrays of them, so that both layouts are the same), and the library file
   "part_bindings". Members are read as block.member. */

#define GLBK_BASE_TEXTURES(X) X(glbk_color_sampler, glbk_source, 0)
#define GLBK_SHOWN_MEMBERS(X)       \
    X(mat4, to_clip, 1)             \
    X(uvec4, how, 1)                /* corner, ints by their bits; glbk_picture: keep_empty, whether with depths */
#define GLBK_BASE_BLOCKS(X) X(glbk_shown, 7, GLBK_SHOWN_MEMBERS)
#define GLBK_BASE_STORAGE(X)
#define GLBK_BASE_IMAGES(X)

#define GLBK__SLOT_TEXTURE(type, name, slot) GLBK_SLOT_##name = slot,
#define GLBK__SLOT_BLOCK(name, slot, members) GLBK_SLOT_##name = slot,
#define GLBK__SLOT_STORAGE(qualifiers, type, name, slot) GLBK_SLOT_##name = slot,
#define GLBK__SLOT_IMAGE(qualifiers, format, type, name, slot) GLBK_SLOT_##name = slot,
#define GLBK__MEMBER_mat4(name, count) float name[16 * (count)];
#define GLBK__MEMBER_vec4(name, count) float name[4 * (count)];
#define GLBK__MEMBER_ivec4(name, count) int32_t name[4 * (count)];
#define GLBK__MEMBER_uvec4(name, count) uint32_t name[4 * (count)];
#define GLBK__MEMBER(type, name, count) GLBK__MEMBER_##type(name, count)
#define GLBK__STRUCT(name, slot, members) typedef struct name { members(GLBK__MEMBER) } name;
#define GLBK__PART(PART)                        \
    enum {                                      \
        GLBK_##PART##_TEXTURES(GLBK__SLOT_TEXTURE)  \
        GLBK_##PART##_BLOCKS(GLBK__SLOT_BLOCK)      \
        GLBK_##PART##_STORAGE(GLBK__SLOT_STORAGE)   \
        GLBK_##PART##_IMAGES(GLBK__SLOT_IMAGE)      \
        GLBK__LAST_SLOT_##PART                  \
    };                                          \
    GLBK_##PART##_BLOCKS(GLBK__STRUCT)
GLBK__PART(BASE)
