/* ---- wavelets: scenes and the light of a picture of all frequencies ----

   Fields of wavelets (SFIELD_BASIS_HAAR) have a scene and a renderer of their own; entities, G-buffer and
   entity numbers are those of harmonics:

       glbk_sfield_haar_upload(gl, &scene_desc, &scene);
       glbk_sfield_haar_create(gl, &desc, &haar);
       glbk_sfield_scene_entities(gl, &scene, entities, count);     // each frame, as for harmonics
       glbk_sfield_haar_sky(gl, &scene, texels);                    // sfield_scene_sky
       glbk_sfield_haar_shade(gl, &haar, &gbuffer, &scene, 0);      // haar.light: times albedo

   A batch of points is shaded at a time. Its passes list what each point meets from near to far, write the
   cubes of these lists, multiply texels, and add them up. Nothing is left out: a point that meets more than
   16 takes further rounds. Products are on texels, as SFIELD_PRODUCT_TEXELS has them, so results are
   sfield_shade's but for roundings: docs/shadowfield.md has the bound. Light without gloss; the passes are
   fragment shaders on every context. */

typedef struct glbk_sfield_haar_scene_desc {
    const sfield_field *const *fields;  /* of wavelets, all with as many texels: occlusion, sources and what
                                           sfield_build_self made. Entities name the first two by these
                                           pointers, glbk_sfield_own the last, so they must outlive the
                                           scene */
    size_t   field_count;
    uint32_t cube_side;                 /* that of the fields; 0 = 32 */
    uint32_t entity_capacity;           /* the most entities, 1..65535 */
    float    reach;                     /* as in glbk_sfield_scene_desc */
} glbk_sfield_haar_scene_desc;

GLBK_DEF glbk_result glbk_sfield_haar_upload(glbk_context *ctx, const glbk_sfield_haar_scene_desc *desc,
                                             glbk_sfield_scene *out);
/* Makes a scene of fields of wavelets, which go up as trees, with room for entities. glbk_sfield_scene_free
   takes the scene back.
   Memory   on the GPU 16 bytes, of sources 32, for each square that holds a wavelet or has such squares
            within, and for six squares of each sample; 112 bytes for each of entity_capacity, and 98 KB for
            the sky of 32 texels a side. Here 40 bytes a field and, while the call runs, the longest file of a
            field and 150 KB
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range. GLBK_ERR_MISMATCH: a
            field of harmonics, of other texels, or a shard. GLBK_ERR_LIMIT: more than 2^28 texels.
            GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_sfield_haar_sky(glbk_context *ctx, glbk_sfield_scene *scene, const float *texels);
/* Sets the environment and its suns.
   texels   3 x 6 cube_side^2 numbers from sfield_scene_sky; NULL = no sky
   Errors   GLBK_ERR_ARGUMENT: scene is NULL or was not created. GLBK_ERR_MISMATCH: the scene has harmonics.
            GLBK_ERR_ALLOC */

typedef struct glbk_sfield_haar_desc {
    uint32_t width;                     /* pixels, 1 .. ctx->max_side, like height */
    uint32_t height;
    uint32_t cube_side;                 /* that of the scene: a power of two, 4..64; 0 = 32 */
    uint32_t batch;                     /* points that are shaded at a time, at most so many as textures of
                                           2048 or ctx->max_side a side hold: 672 of cubes of 16, 168 of 32,
                                           40 of 64. A greater number is taken for that; 0 = 256. More points
                                           make fewer passes */
    int      self;                      /* not 0: there is room for self-visibility, 4 bytes a pixel */
} glbk_sfield_haar_desc;

typedef struct glbk_sfield_haar {       /* the light of a picture; read only; zeroed = none */
    glbk_texture light;                 /* GLBK_FORMAT_COLOR: rgb times albedo is radiance; a is the open
                                           share of the cosine-weighted sphere */
    glbk_target  target;                /* of light, for glbk_target_read */
    glbk_texture self;                  /* private, like all that follows but width, height and cube_side */
    glbk_texture list[3];               /* kinds, and weights of corners and of shells */
    glbk_texture met[2];
    glbk_texture cubes;
    glbk_texture left[2][3];            /* T, in two parts, and sums */
    glbk_target  list_target[2];
    glbk_target  cubes_target;
    glbk_target  left_target[2];
    glbk_program find;
    glbk_program write;
    glbk_program multiply;
    glbk_program sum;
    glbk_buffer  block;
    uint32_t     width;
    uint32_t     height;
    uint32_t     cube_side;
    uint32_t     batch;                 /* points */
    uint32_t     columns;               /* cubes in a row of their texture */
    int          has_self;
    uint64_t     self_of;               /* which scene's places self has; 0 = nothing was said */
} glbk_sfield_haar;

GLBK_DEF glbk_result glbk_sfield_haar_create(glbk_context *ctx, const glbk_sfield_haar_desc *desc,
                                             glbk_sfield_haar *out);
/* Compiles the four programs and makes their textures. For another size free it and create it anew.
   Memory   on the GPU 16 bytes a pixel and, for each point of a batch, 456 cube_side^2 + 1,280 bytes: 30 MB
            for 256 points of 16 texels a side
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range. GLBK_ERR_LIMIT:
            width or height is above ctx->max_side. GLBK_ERR_ALLOC. Those of textures, targets and
            glbk_program_compile */

typedef struct glbk_sfield_own {        /* what a point's own object hides of it */
    const sfield_field *self;           /* by sfield_build_self, one of the scene's fields; NULL = nothing */
    uint32_t            point;          /* its number there */
} glbk_sfield_own;

GLBK_DEF glbk_result glbk_sfield_haar_self(glbk_context *ctx, glbk_sfield_haar *haar,
                                           const glbk_sfield_scene *scene, uint32_t row, uint32_t row_count,
                                           const glbk_sfield_own *own);
/* Says for whole rows of pixels which self-visibility they have, in the space of the entity that the G-buffer
   names there. Pixels that no call named have none. What is said stays from frame to frame, until another
   call says something else of these rows.
   scene    the one that glbk_sfield_haar_shade is given then, since the texture names places in its table, or
            one of the same fields in the same order. The first call for another scene takes self-visibility
            from all other pixels
   own      haar->width x row_count of them
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, an object was not created, or rows reach beyond height.
            GLBK_ERR_MISMATCH: haar has no desc.self, or a field is none of the scene's self-visibilities.
            GLBK_ERR_INPUT: a point is beyond those of its field. GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_sfield_haar_shade(glbk_context *ctx, glbk_sfield_haar *haar,
                                            const glbk_gbuffer *gbuffer, const glbk_sfield_scene *scene,
                                            int open);
/* Shades all pixels into haar->light, in (pixels / batch) batches of 3 passes a round and one more. A round
   takes 16 of what the scene has: its entities, and each light three times more.
   open     not 0: light.a is wanted even if there is no sky; else it is 0 then
   Errors   GLBK_ERR_ARGUMENT: an object is NULL or was not created. GLBK_ERR_MISMATCH: the scene has
            harmonics or other texels or is not the one that self-visibility was named for, or the G-buffer
            has another size. GLBK_ERR_LOST */

GLBK_DEF void glbk_sfield_haar_free(glbk_context *ctx, glbk_sfield_haar *haar);
/* Deletes the renderer's objects of GL and zeroes the struct. Accepts NULL. */

