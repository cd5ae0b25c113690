/* ---- the rest ---- */

GLBK_DEF glbk_result glbk_gbuffer_resize(glbk_context *ctx, glbk_gbuffer *gbuffer,
                                         const struct glbk_gbuffer_desc *desc);
/* Gives the G-buffer another size, without what it held. Its programs stay, whereas a new G-buffer would
   compile them anew; so call it when a window has changed its size. Its textures are new ones: targets of
   yours that have its depth must be made anew.
   desc     attributes is not read: they stay as they were created. depth is that of the new size
   Errors   those of glbk_gbuffer_create. GLBK_ERR_ARGUMENT, too: the G-buffer was not created. After an error
            of desc it is as it was, after any other it is freed and zeroed */

GLBK_DEF void glbk_gbuffer_free(glbk_context *ctx, glbk_gbuffer *gbuffer);
/* Deletes the G-buffer's objects of GL, not your depth texture, and zeroes the struct. NULL is allowed. */

GLBK_DEF glbk_result glbk_gbuffer_read(glbk_context *ctx, const glbk_gbuffer *gbuffer, uint32_t row,
                                       uint32_t row_count, glbk_pixel *pixels);
/* Reads whole rows back, to look at what a G-buffer holds, and waits for the GPU. Normals of surfaces and
   tangents are off by up to 5e-5, occlusion by 1 / 131070.
   pixels   receives gbuffer->width x row_count pixels, in the order of glbk_gbuffer_upload
   Memory   64 bytes a pixel while it runs
   Errors   those of glbk_gbuffer_upload, and of glbk_target_read */

/* ---- shaders of your own ----

   After glbk_gbuffer_bind they read the G-buffer by lib/gbuffer.glsl:

       bool glbk_read_point(ivec2 at, out glbk_point p);            // false: nothing is seen in this pixel

   docs/gpu-layouts.md describes the four textures. */

GLBK_DEF const glbk_part *glbk_gbuffer_part(void);
/* Returns the GLSL of this header, for glbk_source.parts of a program of yours that uses its library
   files. */

GLBK_DEF glbk_result glbk_gbuffer_bind(glbk_context *ctx, const glbk_gbuffer *gbuffer,
                                       const glbk_offset *offset);
/* Binds the four textures for a program of yours that uses lib/gbuffer.glsl and is bound (glbk_begin).
   offset   what glbk_source.offsets gives this part in the program; NULL = none
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the G-buffer was not created */

/* ---- pictures: what the techniques draw at last ---- */

/* The techniques' glbk_..._resolve draw a picture one texel a pixel, its lower left corner at the viewport's.
   A smaller viewport cuts it off; a larger one, or a larger target without a viewport, is GLBK_ERR_DESC:
   nothing is scaled. To show a picture in another size, resolve to a target of its own size and draw that. */

typedef struct glbk_picture {       /* what glbk_..._resolve draws, beside what the pass says. NULL or all
                                       zero: every pixel, without depths */
    int          keep_empty;        /* not 0: where nothing is seen, nothing is drawn: what lies there
                                       stays */
    const float *world_to_clip;     /* 16 floats, OpenGL's clip space -1..1: depths are drawn too, those of
                                       what is seen, 1 where nothing is; pass.depth tests and writes them.
                                       They are recomputed from places, so they may differ in the last bits
                                       from those of a draw of the same surface. NULL: one depth, 0.5, for
                                       all */
} glbk_picture;
/* With desc.check, glbk_..._resolve without pass.target is GLBK_ERR_ORDER while the framebuffer that is bound
   is a technique's, see glbk_check. */

/* ---- for the techniques' headers: not for you, may change without notice ---- */

/* Checks an argument that must not be NULL: returns GLBK_OK, or logs that FIELD is NULL and returns
   GLBK_ERR_ARGUMENT. The other function checks an object, too: `name` points to its name of GL, or is NULL if
   the argument is; an object without a name was not created. Without a context both return GLBK_ERR_ARGUMENT
   and log nothing. */
GLBK__DEF glbk_result glbk__require(const glbk_context *ctx, const char *function, const char *field,
                                    const void *argument);
GLBK__DEF glbk_result glbk__require_created(const glbk_context *ctx, const char *function, const char *field,
                                            const uint32_t *name);

/* Checks a width or height of a desc in pixels, 1 .. ctx->max_side: of too many GLBK_ERR_LIMIT comes, of
   none GLBK_ERR_DESC. */
GLBK__DEF glbk_result glbk__require_side(const glbk_context *ctx, const char *function, const char *field,
                                         uint32_t side);

/* Checks that a G-buffer was created, for pictures of width x height pixels. */
GLBK__DEF glbk_result glbk__require_gbuffer(const glbk_context *ctx, const char *function,
                                            const glbk_gbuffer *gbuffer, uint32_t width, uint32_t height);

/* These log of a member (".radius") of an element of an array what glbk__refuse and glbk__refuse_value log of
   a field: "FUNCTION: ARRAY[INDEX]MEMBER TEXT". With the index GLBK__NO_INDEX the field is ARRAY MEMBER.
   glbk__name_element writes such a field's name. */
enum { GLBK__ELEMENT_ROOM = GLBK__LINE_ROOM };
#define GLBK__NO_INDEX SIZE_MAX
GLBK__DEF void glbk__name_element(char out[GLBK__ELEMENT_ROOM], const char *array, size_t index,
                                  const char *member);
GLBK__DEF glbk_result glbk__refuse_element(const glbk_context *ctx, glbk_result result, const char *function,
                                           const char *array, size_t index, const char *member,
                                           const char *text);
GLBK__DEF glbk_result glbk__refuse_element_value(const glbk_context *ctx, glbk_result result,
                                                 const char *function, const char *array, size_t index,
                                                 const char *member, double value, const char *wanted);

/* Does what glbk__program_create does, for a program of one pass over the screen or of compute that uses
   lib/gbuffer.glsl beside files of its own part. */
GLBK__DEF glbk_result glbk__gbuffer_program(glbk_context *ctx, const glbk_part *part, const char *name,
                                            const char *defines, glbk_program *out);
/* The same with texts of a user, as glbk__program_of_parts takes them. */
GLBK__DEF glbk_result glbk__gbuffer_program_with(glbk_context *ctx, const glbk_part *part, const char *name,
                                                 const char *defines, const char *const texts[2],
                                                 glbk_program *out);

/* The same for a header that stands above another technique's: `under` is the part of that one. */
GLBK__DEF glbk_result glbk__gbuffer_program_above(glbk_context *ctx, const glbk_part *part,
                                                  const glbk_part *under, const char *name,
                                                  const char *defines, glbk_program *out);

/* Copies the locations of attributes with their defaults resolved, and checks that each is at most 15 and
   used once, and that there is a position. function is __func__ of a call whose desc has them. */
GLBK__DEF glbk_result glbk__take_attributes(const glbk_context *ctx, const char *function,
                                            const glbk_attributes *from, glbk_attributes *to);

/* Does what glbk__program_create does, for a program that draws meshes of the user's: its shaders use
   lib/mesh_vertex.glsl and lib/mesh_fragment.glsl, with GLBK_PLACE among the defines for depth alone.
   at     from glbk__take_attributes
   more   defines, which may be "" and have up to 96 characters */
#define GLBK__ATTRIBUTES_ROOM 220
GLBK__DEF glbk_result glbk__drawing_program(glbk_context *ctx, const glbk_part *part, const char *name,
                                            const glbk_attributes *at, const char *more, glbk_program *out);

/* Begins the pass of a resolve as glbk_begin does, for a program that uses lib/picture.glsl and a picture of
   width x height pixels; it checks that the picture covers what is drawn to (glbk_picture). function is
   __func__ of the resolve. */
GLBK__DEF glbk_result glbk__begin_picture(glbk_context *ctx, const char *function, const glbk_pass *pass,
                                          const glbk_picture *picture, uint32_t width, uint32_t height,
                                          glbk_program *program);
