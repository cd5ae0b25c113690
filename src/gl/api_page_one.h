/* ---- page one: a context, and passes that draw ---- */

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

typedef struct glbk_context glbk_context;   /* what a GL context can do, and GL's functions: "the context" */
struct glbk_desc;                   /* how the functions are found, and which units and bindings are ours */
struct glbk_pass;                   /* where a pass draws, and how */
struct glbk_program;                /* GL's name of a program; gl_programs.h compiles some */

GLBK_DEF glbk_result glbk_init(glbk_context *ctx, const struct glbk_desc *desc);
/* Loads GL's functions from the context that is current, decides what the context can do, and makes one empty
   vertex array and one small buffer.
   ctx      is yours, may be moved in memory afterwards, and is zeroed on errors
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. Without a desc there is no log either; GLBK_ERR_DESC;
            GLBK_ERR_CONTEXT; GLBK_ERR_OLD_CONTEXT; GLBK_ERR_FUNCTION: the log has its name; GLBK_ERR_LIMIT:
            first_unit or first_block reach beyond what the context has; GLBK_ERR_PENDING, GLBK_ERR_LOST,
            GLBK_ERR_GL, GLBK_ERR_GL_MEMORY */

GLBK_DEF glbk_result glbk_begin(glbk_context *ctx, const struct glbk_pass *pass,
                                struct glbk_program *program);
/* Begins a pass: sets every state that a draw depends on, so that nothing inherited shows, and binds the
   target, the program and the empty vertex array. Bind textures and blocks after it. docs/gl-state.md lists
   what is touched.
   program  the program to draw with; NULL if you make one the program in use yourself
   Errors   GLBK_ERR_ARGUMENT: ctx or pass is NULL; GLBK_ERR_DESC: a field of pass is out of range, the target
            was not created, or neither target nor viewport is given; GLBK_ERR_LOST. GL's error flag is not
            asked */

GLBK_DEF void glbk_draw_screen(glbk_context *ctx);
/* Draws one triangle over the whole viewport, after glbk_begin, from no attributes. */

GLBK_DEF glbk_result glbk_check(glbk_context *ctx);
/* Takes GL's error flag and returns it as a result, with its number in the log: GLBK_OK, GLBK_ERR_GL,
   GLBK_ERR_GL_MEMORY, or GLBK_ERR_LOST, which no call of a frame notices by itself. Passes and updates do not
   ask for the flag (unless desc.check is set), so call this once a frame; it makes drivers with threads of
   their own wait for what was asked of them. With desc.check it returns GLBK_ERR_ORDER while a technique's
   framebuffer is bound: what you drew since that technique's passes went into it. After such passes bind your
   own framebuffer, or put glbk_state_save and glbk_state_restore round them. */

GLBK_DEF void glbk_free(glbk_context *ctx);
/* Deletes what glbk_init made and zeroes ctx, which may be NULL. Free textures, buffers, targets and programs
   before: afterwards their _free functions call no GL. */

GLBK_DEF const char *glbk_result_text(glbk_result result);
/* Returns what a result means as a constant string, "unknown result" for a value beyond the list. */

/* ---- memory, log: the caller's ---- */

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

/* ---- structs of page one ---- */

#define GLBK_UNITS 16u              /* slots of textures that a part has */
#define GLBK_MAX_UNITS 32u          /* slots of textures in a program with offsets, if the context has so many
                                       units; GL guarantees 16 for one shader stage */
#define GLBK_BLOCKS 8u              /* slots of uniform blocks, and of storage buffers, that a part has */
#define GLBK_MAX_BLOCKS 16u         /* slots of uniform blocks in a program with offsets */
#define GLBK_IMAGES 8u              /* slots of images, which are for compute shaders */
#define GLBK_MAX_PARTS 6u           /* parts that one program can use beside the base: gl_programs.h */

typedef struct glbk_desc {          /* zero it, then set what you care about */
    glbk_system    system;
    glbk_get_proc_fn get_proc_fn;   /* required */
    void          *user;            /* handed to get_proc_fn */
    int            core_only;       /* not 0: only what 3.3 and ES 3.0 share is used, even if the context has
                                       more */
    uint32_t       first_unit;      /* the 16 texture units from first_unit on are ours while we draw. A
                                       program with a glbk_offset also takes units after them, below
                                       first_unit + GLBK_MAX_UNITS */
    uint32_t       first_block;     /* the 8 bindings of uniform blocks from first_block on are ours, too. A
                                       program with a glbk_offset also takes bindings after them, below
                                       first_block + GLBK_MAX_BLOCKS. Storage buffers and images, which are
                                       for compute alone, are always at 0 .. 7, since GLSL says their
                                       numbers */
    int            check;           /* not 0, to look for errors, slowly: calls of a frame ask for GL's error
                                       flag, glbk_check and glbk_..._resolve look which framebuffer is
                                       bound, and glbk_envsh_maps_render draws twice, to find callbacks that
                                       do not draw all instances. Each of these says what it returns */
} glbk_desc;

typedef enum glbk_depth {           /* the depth test, and whether depth is written */
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

typedef struct glbk_pass {          /* if all but the target is zero, a draw overwrites everything */
    const struct glbk_target *target;   /* NULL = the framebuffer that is bound. Then the viewport must be
                                       given, and FRAMEBUFFER_SRGB stays as you have set it: no pass encodes
                                       colours by itself */
    int32_t            viewport[4]; /* x, y, width, height; all zero = the whole target */
    glbk_depth         depth;
    glbk_blend         blend;
    glbk_cull          cull;
    int                no_color;    /* not 0: writes depth only */
    float              offset[2];   /* of depth: factor and units of glPolygonOffset; both 0 = off */
} glbk_pass;

typedef struct glbk_offset {        /* where the slots of a part begin in a program that uses several parts */
    uint32_t unit, block;           /* added to the slots of its textures and of its uniform blocks */
} glbk_offset;

struct glbk_part;                   /* the GLSL of one header: gl_programs.h */

typedef struct glbk_program {       /* read only; zeroed = none. Of a program that you linked yourself set the
                                       name alone, or give glbk_begin NULL */
    uint32_t name;                  /* GL's */
    /* The rest is private. slots_fn gives textures and blocks their slots, and is NULL once it has. */
    void (*slots_fn)(const glbk_context *ctx, const struct glbk_program *program);
    const struct glbk_part *parts[GLBK_MAX_PARTS];
    glbk_offset offsets[GLBK_MAX_PARTS];
} glbk_program;
