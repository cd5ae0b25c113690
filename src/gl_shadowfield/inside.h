/* ---- for gl_wavelets.h: not for you, may change without notice ----

   Its implementation may stand in another file than this header's, hence no static functions: GLBK__DEF is
   GLBK_DEF for them. What stands in one block of lines with an enum stays in leaner headers. */

/* The header of a file of sfield_write, and where the file's parts begin. */
typedef struct glbk__sfield_view {
    const uint8_t *bytes;           /* private, like all that follows */
    uint32_t kind;
    uint32_t bands;
    uint32_t shells;
    uint32_t side;
    uint32_t spacing;               /* an sfield_spacing */
    uint32_t frames;
    uint32_t loop;
    uint32_t channels;
    uint32_t samples;               /* of all frames and shells */
    uint32_t stride;                /* bytes of a sample */
    uint32_t cells;                 /* texels of a sample and channel in the table */
    size_t   scales;                /* where scales and biases begin, bytes */
    size_t   first;                 /* where samples begin, bytes */
} glbk__sfield_view;

/* A stage holds texels on their way into a table. */
typedef struct glbk__sfield_stage {
    glbk_context *ctx;
    const glbk_texture *table;
    uint32_t *words;
    size_t    at;                   /* where in the table the first of them goes */
    size_t    count;                /* texels that wait in words */
    size_t    room;
    glbk_result result;             /* of the first upload that failed */
} glbk__sfield_stage;

enum {
    GLBK__SFIELD_HEADER = 32,           /* words of the header of a file */
    GLBK__SFIELD_STAGE = 1024,          /* texels that go up together */
    GLBK__SFIELD_ENTITY = 7             /* texels of an entity */
};
/* Returns this header's part with its library files for reading fields alone, so that a linker leaves out its
   programs; see glbk__gbuffer_program_above. */
GLBK__DEF const glbk_part *glbk__sfield_reader(void);
/* Reads the header of a file. */
GLBK__DEF void glbk__sfield_read(const uint8_t *bytes, glbk__sfield_view *v);
/* glbk__sfield_texel returns the words of a stage's next texel, zeroed; glbk__sfield_flush uploads the texels
   that wait. */
GLBK__DEF uint32_t *glbk__sfield_texel(glbk__sfield_stage *s);
GLBK__DEF void glbk__sfield_flush(glbk__sfield_stage *s);
/* Returns the measure of a distance, as sfield_measure of lib/sfield_field.glsl does. */
GLBK__DEF float glbk__sfield_measure(float d2, int source, int uniform);
/* Compares two of a scene's fields by their pointers, for qsort; glbk__sfield_find returns a field as it was
   uploaded to a scene whose fields are sorted so, or NULL for NULL and for other fields. */
GLBK__DEF int glbk__sfield_by_pointer(const void *a, const void *b);
GLBK__DEF const glbk_sfield_field *glbk__sfield_find(const glbk_sfield_scene *s, const sfield_field *field);
/* Returns the values of the block that tells shaders what a scene's tables hold; sky: not 0 if the sky or the
   open share is wanted. glbk__sfield_tell uploads the block. */
GLBK__DEF glbk_sfield_contents glbk__sfield_contents_of(const glbk_sfield_scene *s, int sky);
GLBK__DEF glbk_result glbk__sfield_tell(glbk_context *ctx, const glbk_sfield_scene *s);
/* Writes zeros to the first layer of a texture of self-visibility: nothing is recorded. */
GLBK__DEF glbk_result glbk__sfield_blank(glbk_context *ctx, const glbk_texture *self);
/* These check, and log what is wrong: that a scene was created; what descs of scenes of either basis have;
   that a G-buffer has the size of a renderer; that some rows of a picture are there. */
GLBK__DEF glbk_result glbk__sfield_check_scene(const glbk_context *ctx, const char *function,
                                               const glbk_sfield_scene *s);
GLBK__DEF glbk_result glbk__sfield_check_lists(const glbk_context *ctx, const char *function,
                                               const sfield_field *const *fields, size_t field_count,
                                               uint32_t entity_capacity, float reach);
GLBK__DEF glbk_result glbk__sfield_check_gbuffer(const glbk_context *ctx, const char *function,
                                                 uint32_t width, uint32_t height, const glbk_gbuffer *g);
GLBK__DEF glbk_result glbk__sfield_check_rows(const glbk_context *ctx, const char *function, uint32_t height,
                                              uint32_t row, uint32_t row_count);
