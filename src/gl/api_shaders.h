/* ---- GLSL and programs ---- */

typedef struct glbk_file {          /* one file of GLSL, as a header holds it */
    const char        *name;        /* "lib/table.glsl", "prog/copy.frag" */
    const char *const *texts;       /* without comments, and blanks that divide nothing; fit for
                                       glShaderSource */
    uint32_t           text_count;
    const char        *uses;        /* library files that go before it, by bare names: "table csm_bindings" */
    const char        *with;        /* of a .frag: its vertex shader; else "" */
    const char        *sets;        /* the define sets that are tested, separated by " | " */
    const char        *block;       /* the uniform block that it declares, and nothing else; or "" */
} glbk_file;

typedef struct glbk_slot { const char *name; uint32_t slot; } glbk_slot;

/* The GLSL of one header. Each header has a function that returns its own: glbk_base_part for this one,
   glbk_csm_part for gl_csm.h and so on. Nothing is registered anywhere: a program is given the parts whose
   files it uses, and a linker leaves out the GLSL of all others. */
typedef struct glbk_part {
    const char      *name;          /* "csm" */
    const glbk_file *files;
    uint32_t         file_count;
    const glbk_slot *textures, *blocks;     /* each ends with an entry that has no name */
} glbk_part;

#define GLBK_MAX_PARTS 6u           /* that one program can use beside the base, which every program can */

GLBK_DEF const glbk_part *glbk_base_part(void);
/* Returns the GLSL of this header, a constant. */

GLBK_DEF const glbk_file *glbk_find_file(const glbk_part *part, const char *name);
/* Returns a file of the part or else of the base by its name ("lib/table.glsl"), NULL if neither has it. It
   needs no context.
   part   NULL = the base's files alone */

typedef struct glbk_offset {        /* where the slots of a part begin in a program that uses several parts */
    uint32_t unit, block;           /* added to the slots of its textures and of its uniform blocks */
} glbk_offset;

typedef struct glbk_source {        /* a program of your own, with library files */
    const char *vertex;             /* main of the vertex shader as text; NULL = a triangle over the whole
                                       screen */
    const char *fragment;           /* main of the fragment shader as text, or NULL with compute */
    const char *compute;
    const char *uses;               /* library files by their bare names, in order, without what they use
                                       themselves; uniform blocks of the library that your text names are
                                       found */
    const char *defines;            /* "FILTER=1 FAST", or NULL; the vertex shader sees them too */
    const char *outputs;            /* names for transform feedback, separated by blanks, interleaved; or
                                       NULL */
    const glbk_part *parts[GLBK_MAX_PARTS];     /* whose files it uses: glbk_csm_part(), ...; NULLs are left
                                                   out */
    glbk_offset offsets[GLBK_MAX_PARTS];        /* of the slots of each of these parts. What a technique's
                                                   glbk_..._bind binds for this program needs the same
                                                   offset */
} glbk_source;

typedef struct glbk_program {       /* read only; zeroed = none */
    uint32_t name;
    int      slots_set;             /* private */
    const glbk_part *parts[GLBK_MAX_PARTS];     /* private */
    glbk_offset offsets[GLBK_MAX_PARTS];        /* private */
} glbk_program;

GLBK_DEF glbk_result glbk_program_compile(glbk_context *ctx, const glbk_source *source, glbk_program *out);
/* Compiles and links a program from your text, which has no #version line: the text that the driver gets
   begins with that line and lib/prelude.glsl. Compiling takes milliseconds to seconds: do it before the first
   frame.
   source   is read during the call only
   out      is zeroed on errors; free it with glbk_program_free
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, where not one of fragment and compute is given, or outputs are
            too long; GLBK_ERR_NAME, where a library file is unknown or defines do not parse;
            GLBK_ERR_COMPILE, GLBK_ERR_LINK, the driver's words in the log, where line 2007 is line 7 of file
            2, listed there too; GLBK_ERR_ALLOC; GLBK_ERR_FEATURE, for compute without ctx->compute;
            GLBK_ERR_MISMATCH, where two samplers or two uniform blocks that the program declares have one
            texture unit or one binding, both in the log: give one part an offset; GLBK_ERR_LIMIT, where an
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
    const char *name;               /* the file with its main ("prog/copy.frag", which brings its own uses),
                                       or NULL */
    const char *text;               /* your text, behind that file if both are given; or NULL */
    const glbk_part *parts[GLBK_MAX_PARTS];     /* as in glbk_source */
} glbk_shader;

GLBK_DEF size_t glbk_write_glsl(glbk_dialect dialect, int float_bits, const glbk_shader *shader, char *out,
                                size_t bytes);
/* Writes the text that glbk_program_compile gives to the driver for one stage, for a renderer with shaders of
   its own. It needs no context. Returns the bytes that the text needs with its 0, or 0 where a name is
   unknown or defines do not parse.
   float_bits   not 0: GLBK_FORMAT_COLOR targets hold integers, as they do without ctx->float_targets
   out          receives the text, cut to `bytes` bytes and ended by 0; it may be NULL with bytes 0 */

GLBK_DEF void glbk_program_free(glbk_context *ctx, glbk_program *program);
/* Deletes a program and zeroes it. */

GLBK_DEF void glbk_program_use(glbk_context *ctx, glbk_program *program);
/* Makes a program the one in use; at the first time its textures and blocks get their slots. glbk_begin and
   glbk_dispatch do this by themselves. Where program is NULL or the context is lost nothing happens. */

enum { GLBK_SLOT_glbk_user0 = 12, GLBK_SLOT_glbk_user1, GLBK_SLOT_glbk_user2, GLBK_SLOT_glbk_user3 };

GLBK_DEF glbk_result glbk_set_slots(glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                    uint32_t gl_program);
/* Gives the textures and blocks of a program that you linked yourself their slots, as glbk_program_use does
   for the library's: those of the part's and the base's lists that it declares, and samplers of yours that
   are called glbk_user0 to glbk_user3, which have the slots above. Call it once after linking; the program
   need not be in use. The slots 12 to 15 are free beside the functions for your own shaders. They are not
   beside lib/ism_gbuffer.glsl and the programs of rsm and ism themselves: glbk_rsm_states, _coarse, _history
   and _before have 12 to 15, ism's G-buffer and light 11 to 15.
   part         NULL = the base alone
   offset       moves the part's slots; NULL = not at all. The base's stay where they are
   gl_program   GL's name of a linked program
   Errors       GLBK_ERR_ARGUMENT; GLBK_ERR_LIMIT, GLBK_ERR_MISMATCH, as glbk_program_compile says;
                GLBK_ERR_LOST. Nothing is set then */

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
    const glbk_target *target;      /* NULL = the framebuffer that is bound; then the viewport must be given,
                                       and FRAMEBUFFER_SRGB is as you have set it: no pass encodes colours by
                                       itself */
    int32_t            viewport[4]; /* x, y, width, height; all zero = the whole target */
    glbk_depth         depth;
    glbk_blend         blend;
    glbk_cull          cull;
    int                no_color;    /* not 0: writes depth only */
    float              offset[2];   /* of depth: factor and units of glPolygonOffset; both 0 = off */
} glbk_pass;                        /* all zero but the target: overwrite everything */

GLBK_DEF glbk_result glbk_begin(glbk_context *ctx, const glbk_pass *pass, glbk_program *program);
/* Begins a pass: sets every state that a draw depends on, so that nothing inherited shows, and binds the
   target, the program and the empty vertex array. Bind textures and blocks after it. docs/gl-state.md lists
   what is touched.
   program  NULL where you use your own
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_DESC, GLBK_ERR_LOST; GL's error flag is not asked */

GLBK_DEF void glbk_clear(glbk_context *ctx, const glbk_target *target, uint32_t attachment,
                         const float rgba[4]);
/* Fills a colour attachment of the target that glbk_begin has bound, whatever the viewport. Integer formats
   get the numbers, rounded, within 0 and 2^32 - 1; GLBK_FORMAT_COLOR gets the floats. Where an argument is
   NULL or attachment is not below target->count nothing happens. */

GLBK_DEF void glbk_clear_depth(glbk_context *ctx, float depth);
/* Fills the depth of the target that glbk_begin has bound, in a pass whose depth mode writes. depth is 0
   (near) .. 1 (far). */

GLBK_DEF void glbk_bind_texture(glbk_context *ctx, uint32_t slot, const glbk_texture *texture);
/* Binds a texture to a slot for the draws and dispatches that follow, without a sampler object.
   slot      GLBK_SLOT_name of the lists, plus its part's offset, counted from ctx->first_unit on. One beyond
             GLBK_MAX_UNITS or the context's last unit does nothing: bind textures of your own there yourself
   texture   NULL or not created: the unit gets no texture, for a sampler that is declared and not read. What
             others left there may be of another kind than the sampler, and WebGL then refuses to draw */

GLBK_DEF void glbk_bind_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer);
/* Binds a whole buffer as the uniform block of a slot, GLBK_SLOT_name plus its part's offset, counted from
   ctx->first_block on. A slot beyond what the context has does nothing, nor does NULL. */

GLBK_DEF void glbk_bind_storage(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer);
/* Binds a whole buffer as the storage buffer of a slot, 0 .. 7, for compute shaders. Without ctx->compute
   nothing happens. */

GLBK_DEF void glbk_bind_image(glbk_context *ctx, uint32_t slot, const glbk_texture *texture);
/* Binds level 0 of a texture, all layers, to an image slot, 0 .. 7, which compute shaders read and write.
   Without ctx->compute nothing happens. The shader's layout must name the texture's format: rgba32f for
   GLBK_FORMAT_COLOR. GL has no images of sRGB and of depth. */

GLBK_DEF void glbk_draw_screen(glbk_context *ctx);
/* Draws one triangle over the whole viewport, after glbk_begin, from no attributes. */

GLBK_DEF glbk_result glbk_dispatch(glbk_context *ctx, glbk_program *program, uint32_t x, uint32_t y,
                                   uint32_t z);
/* Runs x * y * z groups of a compute program and makes what it wrote visible to everything after it.
   x, y, z  each 0 .. 65535, which every context allows
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_FEATURE without ctx->compute; GLBK_ERR_LOST */

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
/* Keeps every state that passes and binding calls may change, docs/gl-state.md, for glbk_state_restore. Call
   both round a pass or a whole frame of them where the rest of your renderer relies on its state. It asks GL
   some hundred times, which drivers with threads of their own wait for. */

GLBK_DEF void glbk_state_restore(glbk_context *ctx, const glbk_state *state);
/* Sets again what glbk_state_save has kept. What was bound must not be deleted in between; a program that you
   had deleted while it was in use is gone (0) afterwards, as GL says. */

/* ---- bindings ----

   Each part (this header, and each technique's) has four lists, empty where it needs none:

     GLBK_part_TEXTURES(X)   X(GLSL type, name, slot)
     GLBK_part_BLOCKS(X)     X(name, slot, MEMBERS), each with a list MEMBERS(X): X(GLSL type, name, count)
     GLBK_part_STORAGE(X)    X(qualifiers, GLSL type, name, slot), an array without size, for compute
     GLBK_part_IMAGES(X)     X(qualifiers, format, GLSL type, name, slot), for compute

   A list may consist of other lists, each named with (X) behind it. Slots of textures count from 0 to
   GLBK_UNITS - 1, those of blocks, storage and images to 7, anew in each part. A program that uses several
   parts gives each a glbk_offset, so that they do not meet; base being one too, whose slots stay. From the
   lists come GLBK_SLOT_name, the C struct of each block, and the library file "part_bindings". Members are
   read as block.member. Their layout is std140 and that of C at the same time: members are mat4, vec4,
   ivec4, uvec4, arrays of these, and float and uint, four of which fill the place of a vec4; tools/check-
   glsl compares both layouts. */

#define GLBK_BASE_TEXTURES(X) X(glbk_color_sampler, glbk_source, 0)
#define GLBK_BASE_BLOCKS(X)
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
#define GLBK__MEMBER_float(name, count) float name;     /* count is 1: std140 would spread an array */
#define GLBK__MEMBER_uint(name, count) uint32_t name;
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
