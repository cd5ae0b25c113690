/* ---- within a pass ---- */

GLBK_DEF void glbk_program_use(glbk_context *ctx, glbk_program *program);
/* Makes a program the one in use; the first time, its textures and blocks get their slots. glbk_begin and
   glbk_dispatch do this by themselves. If program is NULL or the context is lost, nothing happens. */

GLBK_DEF void glbk_clear(glbk_context *ctx, const glbk_target *target, uint32_t attachment,
                         const float rgba[4]);
/* Fills a colour attachment of the target that glbk_begin has bound, whatever the viewport. Integer formats
   get the numbers, rounded, within 0 and 2^32 - 1; GLBK_FORMAT_COLOR gets the floats. If an argument is NULL
   or attachment is not below target->count, nothing happens. */

GLBK_DEF void glbk_clear_depth(glbk_context *ctx, float depth);
/* Fills the depth of the target that glbk_begin has bound, in a pass whose depth mode writes. depth is 0
   (near) .. 1 (far). */

GLBK_DEF void glbk_bind_texture(glbk_context *ctx, uint32_t slot, const glbk_texture *texture);
/* Binds a texture to a slot for the draws and dispatches that follow, without a sampler object.
   slot      GLBK_SLOT_name of the texture, plus its part's offset, counted from ctx->first_unit on. With a
             slot beyond GLBK_MAX_UNITS or the context's last unit nothing happens: bind textures of your own
             there yourself
   texture   NULL or not created: the unit gets no texture, for a sampler that is declared and not read. A
             texture that others left there may be of another kind than the sampler, and WebGL then refuses to
             draw */

GLBK_DEF void glbk_bind_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer);
/* Binds a whole buffer as the uniform block of a slot, GLBK_SLOT_name plus its part's offset, counted from
   ctx->first_block on. With a slot beyond the context's last binding, or NULL, nothing happens. */

GLBK_DEF void glbk_bind_storage(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer);
/* Binds a whole buffer as the storage buffer of a slot, 0 .. 7, for compute shaders. Without ctx->compute
   nothing happens. */

GLBK_DEF void glbk_bind_image(glbk_context *ctx, uint32_t slot, const glbk_texture *texture);
/* Binds level 0 of a texture, all layers, to an image slot, 0 .. 7, which compute shaders read and write.
   Without ctx->compute nothing happens. The shader's layout must name the texture's format: rgba32f for
   GLBK_FORMAT_COLOR. GL has no images of sRGB and of depth. */

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
   both round a pass or a whole frame of them where the rest of your renderer relies on its state. The call
   asks GL some hundred questions, for each of which drivers with threads of their own wait. */

GLBK_DEF void glbk_state_restore(glbk_context *ctx, const glbk_state *state);
/* Sets again what glbk_state_save has kept. What was bound must not be deleted in between; a program that you
   had deleted while it was in use is gone (0) afterwards, as GL says. */
