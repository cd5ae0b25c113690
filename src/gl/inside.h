/* ---- for the techniques' headers: not for you, may change without notice ----

   Their implementations may stand in other files than this header's, hence no static functions: GLBK__DEF is
   GLBK_DEF for them. */

#define GLBK__TEXTURE_ENTRY(type, name, slot) { #name, slot },
#define GLBK__BLOCK_ENTRY(name, slot, members) { #name "_block", slot },
#define GLBK__PART_CODE(part, PART)                                                                \
    static const glbk_slot glbk__##part##_units[] = {                                              \
        GLBK_##PART##_TEXTURES(GLBK__TEXTURE_ENTRY) { NULL, 0 }                                    \
    };                                                                                             \
    static const glbk_slot glbk__##part##_bindings[] = {                                           \
        GLBK_##PART##_BLOCKS(GLBK__BLOCK_ENTRY) { NULL, 0 }                                        \
    };                                                                                             \
    GLBK__PART_FUNCTION(part)
#define GLBK__PART_FUNCTION(part)                                                                  \
    static const glbk_part glbk__##part##_part = {                                                 \
        #part, glbk__##part##_files, sizeof glbk__##part##_files / sizeof glbk__##part##_files[0], \
        glbk__##part##_units, glbk__##part##_bindings                                              \
    };                                                                                             \
    GLBK_DEF const glbk_part *glbk_##part##_part(void) { return &glbk__##part##_part; }

/* Every call that can fail and calls GL begins with glbk__enter, which returns GLBK_ERR_ARGUMENT for no
   context, GLBK_ERR_LOST, or GLBK_ERR_PENDING, and ends with glbk__leave, which returns the errors that GL
   has kept since. A call of a frame ends with glbk__leave_frame, which asks GL with desc.check alone.
   glbk__leave_created ends a creating call whose last steps were those of a frame: where result is GLBK_OK it
   asks GL. */
GLBK__DEF glbk_result glbk__enter(glbk_context *ctx);
GLBK__DEF glbk_result glbk__leave(glbk_context *ctx);
GLBK__DEF glbk_result glbk__leave_frame(glbk_context *ctx);
GLBK__DEF glbk_result glbk__leave_created(glbk_context *ctx, glbk_result result);

/* These log why a call fails and return the result: "FUNCTION: FIELD TEXT"; "FUNCTION: FIELD is VALUE; it
   must be WANTED"; "FUNCTION: FIELD is VALUE; it must be LOW..HIGH". function is __func__ of the public
   function. */
GLBK__DEF glbk_result glbk__refuse(const glbk_context *ctx, glbk_result result, const char *function,
                                   const char *field, const char *text);
GLBK__DEF glbk_result glbk__refuse_value(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *field, double value, const char *wanted);
GLBK__DEF glbk_result glbk__refuse_range(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *field, double value, double low, double high);
/* Logs "FUNCTION: MESH: index 2 of triangle 17 is 90, but the mesh has 80 vertices" and returns the result;
   position counts indices from 0. */
GLBK__DEF glbk_result glbk__refuse_index(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *mesh, size_t position, size_t index,
                                         size_t vertex_count);

/* Returns *offset, or zeros for NULL. */
GLBK__DEF glbk_offset glbk__offset(const glbk_offset *offset);

/* Gives a uniform block all its values for the draws that follow, and binds it to its slot. */
GLBK__DEF glbk_result glbk__put_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer,
                                      const void *values);

/* glbk__canvas makes a texture and a target of it, with `depth` if that is not NULL. glbk__target_create
   makes a target as glbk_target_create does. Both are a technique's own: nobody else is to draw to them,
   which glbk_check looks for. glbk__attach attaches a texture to the framebuffer that is bound; NULL does
   nothing. */
GLBK__DEF glbk_result glbk__canvas(glbk_context *ctx, glbk_format format, uint32_t width, uint32_t height,
                                   const glbk_texture *depth, glbk_texture *texture, glbk_target *target);
GLBK__DEF glbk_result glbk__target_create(glbk_context *ctx, const glbk_target_desc *desc, glbk_target *out);
GLBK__DEF void glbk__attach(const glbk_context *ctx, uint32_t attachment, const glbk_texture *t,
                            uint32_t level, uint32_t layer);

/* With desc.check, returns GLBK_ERR_ORDER and logs it while a technique's framebuffer is bound. */
GLBK__DEF glbk_result glbk__check_bound(const glbk_context *ctx, const char *function);

/* Enables or disables what glEnable knows by that name. */
GLBK__DEF void glbk__set_cap(const glbk_context *ctx, uint32_t name, int on);

/* Compiles and links a program of the library.
   part     has it; NULL = the base
   other    a second part whose library files it uses, or NULL
   name     is that of its last stage: "copy.frag", "csm_query.comp"
   defines  one of its sets, or NULL = none
   Errors   those of glbk_program_compile; GLBK_ERR_NAME where the part has no such file */
GLBK__DEF glbk_result glbk__program_create(glbk_context *ctx, const glbk_part *part, const char *name,
                                           const char *defines, glbk_program *out);
GLBK__DEF glbk_result glbk__program_of_parts(glbk_context *ctx, const glbk_part *part, const glbk_part *other,
                                             const char *name, const char *defines, glbk_program *out);

/* A table is an array texture that lib/table.glsl reads by one number: texel i stands at (i & 1023, i >> 10 &
   1023, i >> 20). texels: count of them, 1 .. ctx->max_layers * 2^20, in any format but the depth formats, or
   NULL = undefined. On the GPU it takes count rounded up to rows of 1024, above 2^20 texels to layers of
   2^20; beyond ctx->max_layers of them it is GLBK_ERR_LIMIT. Updating sets count texels from number first on,
   as a call of a frame. */
GLBK__DEF glbk_result glbk__table_create(glbk_context *ctx, glbk_format format, const void *texels,
                                         size_t count, glbk_texture *out);
GLBK__DEF glbk_result glbk__table_update(glbk_context *ctx, const glbk_texture *table, size_t first,
                                         size_t count, const void *texels);

/* Text that is counted in `used` and written as far as there is room: glbk__append adds so many characters,
   glbk__append_text a string, glbk__append_file a file of GLSL. */
typedef struct glbk__sink {
    char  *out;
    size_t bytes, used;
} glbk__sink;
GLBK__DEF void glbk__append(glbk__sink *sink, const char *text, size_t length);
GLBK__DEF void glbk__append_text(glbk__sink *sink, const char *text);
GLBK__DEF void glbk__append_file(glbk__sink *sink, const glbk_file *file);
