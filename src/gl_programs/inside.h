/* ---- for the techniques' headers: not for you, may change without notice ----

   Their implementations may stand in other files than this header's, hence no static functions: GLBK__DEF is
   GLBK_DEF for them. */

/* GLBK__TIGHT stands behind the name of a file of GLSL: gcc would begin each at a multiple of 32 bytes. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define GLBK__TIGHT __attribute__((aligned(1)))
#else
#define GLBK__TIGHT
#endif

/* Lists of slots as glbk_part has them. */
#define GLBK__TEXTURE_ENTRY(type, name, slot) #slot " " #name "\0"
#define GLBK__BLOCK_ENTRY(name, slot, members) #slot " " #name "_block\0"
#define GLBK__STORAGE_ENTRY(qualifiers, type, name, slot) #slot " " #name "_storage\0"
#define GLBK__IMAGE_ENTRY(qualifiers, format, type, name, slot) #slot " " #name "\0"
#define GLBK__LISTS_CODE(part, PART)                                                               \
    static const char glbk__##part##_slots[] =                                                     \
        GLBK_##PART##_TEXTURES(GLBK__TEXTURE_ENTRY) "\0" GLBK_##PART##_BLOCKS(GLBK__BLOCK_ENTRY)   \
        "\0" GLBK_##PART##_STORAGE(GLBK__STORAGE_ENTRY) "\0"                                       \
        GLBK_##PART##_IMAGES(GLBK__IMAGE_ENTRY) "\0";
#define GLBK__PART_DATA(part)                                                                      \
    static const glbk_part glbk__##part##_part = {                                                 \
        #part, glbk__##part##_files, sizeof glbk__##part##_files / sizeof glbk__##part##_files[0], \
        glbk__##part##_slots                                                                       \
    };
#define GLBK__PART_CODE(part, PART)                                                                \
    GLBK__LISTS_CODE(part, PART)                                                                   \
    GLBK__PART_DATA(part)                                                                          \
    GLBK_DEF const glbk_part *glbk_##part##_part(void) { return &glbk__##part##_part; }

/* Returns the base, which the public functions take for a part that is NULL. */
GLBK__DEF const glbk_part *glbk__base(void);

/* Returns *offset, or zeros for NULL. */
GLBK__DEF glbk_offset glbk__offset(const glbk_offset *offset);

/* Compiles and links a program of the library.
   part     has it; NULL = the base
   others   more parts whose library files it uses, NULLs left out; or NULL
   texts    of a user, before the vertex and the fragment shader; NULL, or one of them NULL = none
   name     is that of its last stage: "copy.frag", "csm_query.comp"
   defines  one of its sets, or NULL = none
   Errors   those of glbk_program_compile; GLBK_ERR_NAME where the part has no such file */
GLBK__DEF glbk_result glbk__program_create(glbk_context *ctx, const glbk_part *part, const char *name,
                                           const char *defines, glbk_program *out);
GLBK__DEF glbk_result glbk__program_of_parts(glbk_context *ctx, const glbk_part *part,
                                             const glbk_part *const others[2], const char *name,
                                             const char *defines, const char *const texts[2],
                                             glbk_program *out);

/* Returns one of the strings that follow the name of a file. */
enum { GLBK__FILE_USES = 1, GLBK__FILE_WITH, GLBK__FILE_SETS, GLBK__FILE_BLOCK, GLBK__FILE_TEXT };
GLBK__DEF const char *glbk__file_fact(const glbk_file *file, int which);

/* Text that is counted in `used` and written as far as there is room: glbk__append adds so many characters,
   glbk__append_text a string, glbk__append_number its digits, glbk__append_file a file of GLSL.
   glbk__begin_line begins a line for the log, which is always ended by 0. */
enum { GLBK__LINE_ROOM = 256 };     /* characters; of longer lines the end is cut off */
typedef struct glbk__sink {
    char  *out;
    size_t bytes, used;
} glbk__sink;
GLBK__DEF void glbk__append(glbk__sink *sink, const char *text, size_t length);
GLBK__DEF void glbk__append_text(glbk__sink *sink, const char *text);
GLBK__DEF void glbk__append_number(glbk__sink *sink, uint64_t number);
GLBK__DEF void glbk__append_file(glbk__sink *sink, const glbk_file *file);
GLBK__DEF void glbk__begin_line(glbk__sink *sink, char out[GLBK__LINE_ROOM]);

/* Logs "FUNCTION: MESH: index 2 of triangle 17 is 90, but the mesh has 80 vertices" and returns the result;
   position counts indices from 0. */
GLBK__DEF glbk_result glbk__refuse_index(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *mesh, size_t position, size_t index,
                                         size_t vertex_count);

/* Gives a uniform block all its values for the draws that follow, and binds it to its slot. */
GLBK__DEF glbk_result glbk__put_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer,
                                      const void *values);

/* Makes a texture and a target of it, with `depth` if that is not NULL. The target is a technique's own, as
   those of glbk__target_create are. */
GLBK__DEF glbk_result glbk__canvas(glbk_context *ctx, glbk_format format, uint32_t width, uint32_t height,
                                   const glbk_texture *depth, glbk_texture *texture, glbk_target *target);

/* Makes what a technique sums light in: one canvas, or two where passes draw from one into the other, which
   is so without compute. What there is of them goes when an error comes. */
GLBK__DEF glbk_result glbk__sums_create(glbk_context *ctx, int compute, uint32_t width, uint32_t height,
                                        glbk_texture sums[2], glbk_target targets[2]);
GLBK__DEF void glbk__sums_free(glbk_context *ctx, glbk_texture sums[2], glbk_target targets[2]);

/* A table is an array texture that lib/table.glsl reads by one number: texel i stands at (i & 1023, i >> 10 &
   1023, i >> 20). texels: count of them, 1 .. ctx->max_layers * 2^20, in any format but the depth formats, or
   NULL = undefined. On the GPU a table takes count rounded up to rows of 1024, above 2^20 texels to layers of
   2^20; beyond ctx->max_layers of them it is GLBK_ERR_LIMIT. Updating sets count texels from number first on,
   as a call of a frame. */
GLBK__DEF glbk_result glbk__table_create(glbk_context *ctx, glbk_format format, const void *texels,
                                         size_t count, glbk_texture *out);
GLBK__DEF glbk_result glbk__table_update(glbk_context *ctx, const glbk_texture *table, size_t first,
                                         size_t count, const void *texels);
