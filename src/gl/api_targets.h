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
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL; GLBK_ERR_DESC: there is no attachment, or a texture does not
            have that layer or level; GLBK_ERR_MISMATCH: sizes differ, or a depth texture stands for colours;
            GLBK_ERR_FLOAT_TARGET: floats without ctx->float_targets; GLBK_ERR_TARGET: the driver cannot draw
            to this combination */

GLBK_DEF glbk_result glbk_target_read(glbk_context *ctx, const glbk_target *target, uint32_t attachment,
                                      uint32_t x, uint32_t y, uint32_t width, uint32_t height, void *rgba);
/* Copies width x height pixels of a colour attachment from the GPU, from pixel (x, y) on, rows from the
   bottom up. The call waits until the GPU has done all its work.
   attachment   0 .. target->count - 1
   rgba         receives 16 bytes a pixel: four floats, or four uint32_t where the format has integers. Of a
                GLBK_FORMAT_COLOR target these are the floats in either case
   Errors       GLBK_ERR_ARGUMENT, also where the pixels do not lie within the target */

GLBK_DEF void glbk_target_free(glbk_context *ctx, glbk_target *target);
/* Deletes a framebuffer, not its textures, and zeroes the struct. NULL and zeroed ones are allowed. */
