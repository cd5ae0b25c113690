/* ---- for the techniques' headers: not for you, may change without notice ----

   Their implementations may stand in other files than this header's, hence no static functions: GLBK__DEF is
   GLBK_DEF for them. */

/* Every call that can fail and calls GL begins with glbk__enter, which returns GLBK_ERR_ARGUMENT for no
   context, GLBK_ERR_LOST, or GLBK_ERR_PENDING, and ends with glbk__leave, which returns the errors that GL
   has kept since. A call of a frame begins with glbk__enter_frame and ends with glbk__leave_frame, which ask
   GL with desc.check alone. A creating call begins with glbk__enter_create, which zeroes the `bytes` bytes of
   its output and refuses NULL; glbk__leave_created ends one whose last steps were those of a frame: if result
   is GLBK_OK it asks GL. */
GLBK__DEF glbk_result glbk__enter(glbk_context *ctx);
GLBK__DEF glbk_result glbk__enter_frame(glbk_context *ctx);
GLBK__DEF glbk_result glbk__enter_create(glbk_context *ctx, const char *function, void *out, size_t bytes);
GLBK__DEF glbk_result glbk__leave(glbk_context *ctx);
GLBK__DEF glbk_result glbk__leave_frame(glbk_context *ctx);
GLBK__DEF glbk_result glbk__leave_created(glbk_context *ctx, glbk_result result);

/* These three log why a call fails and return the result: "FUNCTION: FIELD TEXT"; "FUNCTION: FIELD is VALUE;
   it must be WANTED"; "FUNCTION: FIELD is VALUE; it must be LOW..HIGH". function is __func__ of the public
   function. */
GLBK__DEF glbk_result glbk__refuse(const glbk_context *ctx, glbk_result result, const char *function,
                                   const char *field, const char *text);
GLBK__DEF glbk_result glbk__refuse_value(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *field, double value, const char *wanted);
GLBK__DEF glbk_result glbk__refuse_range(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *field, double value, double low, double high);
/* glbk__target_create makes a target of a technique's own as glbk_target_create does. Nobody else may draw to
   such a target; glbk_check looks whether somebody does. glbk__attach attaches a texture to the framebuffer
   that is bound; if the texture is NULL it does nothing. */
GLBK__DEF glbk_result glbk__target_create(glbk_context *ctx, const glbk_target_desc *desc, glbk_target *out);
GLBK__DEF void glbk__attach(const glbk_context *ctx, uint32_t attachment, const glbk_texture *t,
                            uint32_t level, uint32_t layer);

/* With desc.check, returns GLBK_ERR_ORDER and logs it while a technique's framebuffer is bound. */
GLBK__DEF glbk_result glbk__check_bound(const glbk_context *ctx, const char *function);

/* Enables or disables a capability, the name that glEnable takes. */
GLBK__DEF void glbk__set_cap(const glbk_context *ctx, uint32_t name, int on);

/* Returns a whole number that GL keeps under this name, the first one if there are several. */
GLBK__DEF uint32_t glbk__get_integer(const glbk_context *ctx, uint32_t name);

/* GL's bindings and parameters of texels in memory that an upload replaces and puts back. Several boxes may
   be uploaded between glbk__upload_begin and glbk__upload_end; they are not checked. */
typedef struct glbk__store {
    int32_t value[8], buffer;
} glbk__store;
typedef struct glbk__upload {
    glbk__store store;
    int32_t     bound;
} glbk__upload;
GLBK__DEF void glbk__upload_begin(const glbk_context *ctx, const glbk_texture *t, glbk__upload *old);
GLBK__DEF void glbk__upload_box(const glbk_context *ctx, const glbk_texture *t, const glbk_box *b,
                                const void *data);
GLBK__DEF void glbk__upload_end(const glbk_context *ctx, const glbk_texture *t, const glbk__upload *old);

/* Returns the bytes of a texel in memory. */
GLBK__DEF uint32_t glbk__texel_bytes(glbk_format format);
