/* ---- for the techniques' headers: not for you, may change without notice ----

   Their implementations may stand in other files than this header's, hence no static functions. */

#define GLBK__TEXTURE_ENTRY(type, name, slot) { #name, slot },
#define GLBK__BLOCK_ENTRY(name, slot, members) { #name "_block", slot },
#define GLBK__PART_CODE(part, PART)                                                                         \
    static const glbk_slot glbk__##part##_units[] = { GLBK_##PART##_TEXTURES(GLBK__TEXTURE_ENTRY) { NULL, 0 } };  \
    static const glbk_slot glbk__##part##_bindings[] = { GLBK_##PART##_BLOCKS(GLBK__BLOCK_ENTRY) { NULL, 0 } };   \
    static const glbk_part glbk__##part##_part = {                                                          \
        #part, glbk__##part##_files, sizeof glbk__##part##_files / sizeof glbk__##part##_files[0],          \
        glbk__##part##_units, glbk__##part##_bindings                                                       \
    };                                                                                                      \
    GLBK_DEF const glbk_part *glbk_##part##_part(void) { return &glbk__##part##_part; }

/* Every call that can fail and calls GL begins and ends with enter and leave; those of a frame ask for GL's error flag
   only with desc.check. made: the end of a creating call whose last steps were a frame's. */
GLBK_DEF glbk_result glbk__enter(glbk_context *ctx);
GLBK_DEF glbk_result glbk__leave(glbk_context *ctx);
GLBK_DEF glbk_result glbk__leave_frame(glbk_context *ctx);
GLBK_DEF glbk_result glbk__made(glbk_context *ctx, glbk_result result);

/* These log why a call fails and return the result: "FUNCTION: FIELD TEXT"; "FUNCTION: FIELD is VALUE; it must be
   WANTED"; "FUNCTION: FIELD is VALUE; it must be LOW..HIGH". function is __func__ of the public function. */
GLBK_DEF glbk_result glbk__bad(const glbk_context *ctx, glbk_result result, const char *function, const char *field,
                               const char *text);
GLBK_DEF glbk_result glbk__bad_value(const glbk_context *ctx, glbk_result result, const char *function,
                                     const char *field, double value, const char *wanted);
GLBK_DEF glbk_result glbk__bad_range(const glbk_context *ctx, glbk_result result, const char *function,
                                     const char *field, double value, double low, double high);
/* "FUNCTION: MESH: index 2 of triangle 17 is 90, but the mesh has 80 vertices"; position counts indices from 0. */
GLBK_DEF glbk_result glbk__bad_index(const glbk_context *ctx, glbk_result result, const char *function,
                                     const char *mesh, size_t position, size_t index, size_t vertex_count);

static inline glbk_offset glbk__offset(const glbk_offset *offset)
{
    const glbk_offset none = { 0, 0 };
    return offset ? *offset : none;
}

/* All values of a block or storage buffer for the draws that follow, bound to its slot. */
GLBK_DEF glbk_result glbk__put_values(glbk_context *ctx, uint32_t target, uint32_t slot, const glbk_buffer *buffer,
                                      const void *values);
GLBK_DEF glbk_result glbk__put_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer, const void *values);

/* glbk_target_create for a target that is a technique's own: nobody else is to draw to it. canvas: likewise with a
   texture that it makes. attach: a texture into the framebuffer that is bound. */
GLBK_DEF glbk_result glbk__canvas(glbk_context *ctx, glbk_format format, uint32_t width, uint32_t height,
                                  const glbk_texture *depth, glbk_texture *texture, glbk_target *target);
GLBK_DEF glbk_result glbk__target_create(glbk_context *ctx, const glbk_target_desc *desc, glbk_target *out);
GLBK_DEF void glbk__attach(const glbk_context *ctx, uint32_t attachment, const glbk_texture *t, uint32_t level,
                           uint32_t layer);
GLBK_DEF void glbk__set_cap(const glbk_context *ctx, uint32_t name, int on);

/* glbk_begin for a resolve, whose program uses lib/picture.glsl: a picture of width x height, see glbk_picture. */
GLBK_DEF glbk_result glbk__begin_picture(glbk_context *ctx, const glbk_pass *pass, const glbk_picture *picture,
                                         uint32_t width, uint32_t height, glbk_program *program);

/* glbk_program_create where the file uses files of another part, too; other may be NULL. */
GLBK_DEF glbk_result glbk__program_of_parts(glbk_context *ctx, const glbk_part *part, const glbk_part *other,
                                            const char *name, const char *defines, glbk_program *out);

/* Text that is counted in `used` and written as far as there is room. */
typedef struct glbk__sink {
    char  *out;
    size_t bytes, used;
} glbk__sink;
GLBK_DEF void glbk__put(glbk__sink *sink, const char *text, size_t length);
GLBK_DEF void glbk__put_text(glbk__sink *sink, const char *text);
GLBK_DEF void glbk__put_file(glbk__sink *sink, const glbk_file *file);
