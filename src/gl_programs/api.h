/* ---- page one: a program of your own, with functions of the library ---- */

struct glbk_source;                 /* your text, and whose functions it calls */
struct glbk_part;                   /* the GLSL of one header, as glbk_csm_part() returns it */

GLBK_DEF glbk_result glbk_program_compile(glbk_context *ctx, const struct glbk_source *source,
                                          glbk_program *out);
/* Compiles and links a program from your text, which has no #version line: the text that the driver gets
   begins with that line and lib/prelude.glsl. Compiling takes milliseconds to seconds: do it before the first
   frame.
   source   is read during the call only
   out      is zeroed on errors; free it with glbk_program_free
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL.
            GLBK_ERR_DESC: not exactly one of fragment and compute is given, or outputs are too many or long.
            GLBK_ERR_NAME: a library file is unknown, or defines do not parse.
            GLBK_ERR_COMPILE, GLBK_ERR_LINK: the log has the driver's words, in which line 2007 is line 7 of
            file 2; the log lists the files, too.
            GLBK_ERR_FEATURE: compute without ctx->compute.
            GLBK_ERR_MISMATCH: two samplers or uniform blocks that the program declares have the same texture
            unit or binding, so that one part needs an offset; or two storage buffers or images have the same
            number, so that each of these parts needs a program of its own. The log has both names.
            GLBK_ERR_LIMIT: an offset leads beyond GLBK_MAX_UNITS, GLBK_MAX_BLOCKS or what the context has
            from first_unit on, or a text is longer than INT32_MAX. GLBK_ERR_ALLOC */

GLBK_DEF void glbk_program_free(glbk_context *ctx, glbk_program *program);
/* Deletes a program and zeroes the struct. NULL and zeroed ones are allowed. */

GLBK_DEF glbk_result glbk_dispatch(glbk_context *ctx, glbk_program *program, uint32_t x, uint32_t y,
                                   uint32_t z);
/* Runs x * y * z groups of a compute program, for which everything is bound, and makes what it wrote visible
   to everything after it.
   x, y, z  each 0 .. 65535, which every context allows
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the program was not created; GLBK_ERR_FEATURE: there is
            no ctx->compute; GLBK_ERR_LOST */

/* ---- structs of page one ---- */

typedef struct glbk_source {
    const char *vertex;             /* main of the vertex shader as text; NULL = a triangle over the whole
                                       screen */
    const char *fragment;           /* main of the fragment shader as text, or NULL with compute */
    const char *compute;            /* main of a compute shader as text, in place of both */
    const char *uses;               /* library files by their bare names, in order, without what they use
                                       themselves; uniform blocks of the library that your text names are
                                       found */
    const char *defines;            /* "FILTER=1 FAST", or NULL; the vertex shader sees them too */
    const char *outputs;            /* names for transform feedback, at most 16 and 511 characters, separated
                                       by blanks, interleaved; or NULL */
    const struct glbk_part *parts[GLBK_MAX_PARTS];  /* whose files it uses: glbk_csm_part(), ...; NULLs are
                                       left out */
    glbk_offset offsets[GLBK_MAX_PARTS];    /* of the slots of each of these parts. What a technique's
                                       glbk_..._bind binds for this program needs the same offset */
} glbk_source;

/* ---- the GLSL of the headers ---- */

typedef struct glbk_file {      /* one file of GLSL, as a header holds it: strings one after the other, each
                                   ended by 0, since tables of pointers would take more than the strings */
    const char *name;           /* "lib/table.glsl", "prog/copy.frag". Private strings follow it: the bare
                                   names of the library files that go before this one, the vertex shader that
                                   a .frag goes with, the define sets that are tested, separated by " | ", and
                                   the uniform block that the file declares and nothing else. Behind them is
                                   what glbk_file_text returns */
} glbk_file;

/* The GLSL of one header. Each header has a function that returns its own: glbk_csm_part for gl_csm.h and so
   on. Nothing is registered anywhere: a program is given the parts whose files it uses, and a linker leaves
   out the GLSL of all others. The base is the GLSL of this header, which every program has. */
typedef struct glbk_part {
    const char      *name;          /* "csm" */
    const glbk_file *files;
    uint32_t         file_count;
    const char      *slots;         /* which slot each name of its GLSL has, "3 glbk_csm_maps": a number, one
                                       blank, the name. Four lists of such strings, each string ended by 0 and
                                       each list by an empty string: textures, uniform blocks, storage
                                       buffers, images. Never NULL: "\0\0\0" has four empty lists */
} glbk_part;

GLBK_DEF const glbk_file *glbk_find_file(const glbk_part *part, const char *name);
/* Returns a file of the part or else of the base by its name ("lib/table.glsl"), NULL if neither has it. It
   needs no context.
   part   NULL = the base's files alone */

GLBK_DEF const char *glbk_file_text(const glbk_file *file);
/* Returns a file's text without comments and idle blanks. It comes in pieces: the others follow the first,
   each ended by 0, and an empty string follows the last.
   file   NULL = NULL is returned */

/* ---- programs that you link yourself ---- */

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
    const char *text;               /* your text, before that file if both are given; or NULL */
    const glbk_part *parts[GLBK_MAX_PARTS];     /* as in glbk_source */
} glbk_shader;

GLBK_DEF size_t glbk_write_glsl(glbk_dialect dialect, int float_bits, const glbk_shader *shader, char *out,
                                size_t bytes);
/* Writes the text that glbk_program_compile gives to the driver for one stage, for a renderer that compiles
   its shaders itself. Returns the bytes that the text needs with its 0, or 0 if a name is unknown or defines
   do not parse. It needs no context, and so has no log.
   float_bits   not 0: GLBK_FORMAT_COLOR targets hold integers, as they do without ctx->float_targets
   out          receives the text, cut to `bytes` bytes and ended by 0; it may be NULL with bytes 0 */

enum { GLBK_SLOT_glbk_user0 = 12, GLBK_SLOT_glbk_user1, GLBK_SLOT_glbk_user2, GLBK_SLOT_glbk_user3 };

GLBK_DEF glbk_result glbk_set_slots(glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                    uint32_t gl_program);
/* Gives the textures and blocks of a program that you linked yourself their slots, as glbk_program_use does
   for the library's: those of the part's and the base's lists that the program declares, and samplers of
   yours that are called glbk_user0 to glbk_user3, which have the slots above. Call it once for each part,
   after linking; the program need not be in use. The slots 12 to 15 are free beside the functions for your
   own shaders; the programs of rsm and ism themselves have textures there.
   part         NULL = the base alone
   offset       moves the part's slots; NULL = not at all. The base's stay where they are
   gl_program   GL's name of a linked program
   Errors       GLBK_ERR_ARGUMENT: ctx is NULL, or gl_program is 0; GLBK_ERR_LIMIT: as glbk_program_compile
                says; GLBK_ERR_MISMATCH: a sampler or block of the part would have the unit or binding of
                another one of the program, whatever gave it to that one; the log has both names. A sampler of
                yours with another name counts if its unit is not 0, GL's default; GLBK_ERR_LOST. Nothing is
                set then
   A sampler or block of a part whose turn is still to come is put out of the way, to the last unit or binding
   that GL has. */
