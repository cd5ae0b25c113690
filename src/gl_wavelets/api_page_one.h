/* ---- page one: a scene of wavelets that lights the pixels of a G-buffer ---- */

typedef struct glbk_sfield_haar glbk_sfield_haar;   /* the light of a picture: see "objects" below */
struct glbk_sfield_haar_scene_desc;     /* which fields, how many entities: below */
struct glbk_sfield_haar_desc;           /* how large the picture is: below */

GLBK_DEF glbk_result glbk_sfield_haar_upload(glbk_context *ctx,
                                             const struct glbk_sfield_haar_scene_desc *desc,
                                             glbk_sfield_scene *out);
/* Makes a scene of fields of wavelets, with room for entities. They go up as trees or, if ctx->compute is set
   and cube_side is at most 32, as lists of coefficients. glbk_sfield_scene_free takes the scene back.
   Memory   on the GPU of trees 16 bytes, of sources 32, for each square that holds a wavelet or has such
            squares within, and for six squares of each sample; of lists 4 bytes, of sources 8, for each
            coefficient, and 16 to 28 bytes for each sample; 112 bytes for each of entity_capacity, and 98
            KB for the sky of 32 texels a side. Here 40 bytes a field and, while the call runs, the
            longest file of a field and 150 KB
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range. GLBK_ERR_MISMATCH: a
            field of harmonics, of other texels, or a shard. GLBK_ERR_LIMIT: more than 2^28 texels.
            GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_sfield_haar_sky(glbk_context *ctx, glbk_sfield_scene *scene, const float *texels);
/* Sets the environment and its suns.
   texels   3 x 6 cube_side^2 numbers from sfield_scene_sky; NULL = no sky
   Errors   GLBK_ERR_ARGUMENT: scene is NULL or was not created. GLBK_ERR_MISMATCH: the scene has harmonics.
            GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_sfield_haar_create(glbk_context *ctx, const struct glbk_sfield_haar_desc *desc,
                                             glbk_sfield_haar *out);
/* Compiles the four programs and makes their textures; or the compute shader, where scenes have lists. For
   another size free it and create it anew.
   Memory   on the GPU 16 bytes a pixel and, for each point of a batch, 456 cube_side^2 + 1,280 bytes: 30 MB
            for 256 points of 16 texels a side. By compute 24 cube_side^2 bytes for each point of a batch,
            above 16 texels a side: 50 MB for 2,048 points of 32. With gloss 16 bytes a pixel and, for each
            point of a batch, 48 cube_side^2 bytes more, 72 by compute
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range. GLBK_ERR_LIMIT:
            width or height is above ctx->max_side. GLBK_ERR_ALLOC. Those of textures, targets and
            glbk_program_compile */

GLBK_DEF glbk_result glbk_sfield_haar_shade(glbk_context *ctx, glbk_sfield_haar *haar,
                                            const glbk_gbuffer *gbuffer, const glbk_sfield_scene *scene,
                                            const float eye[3], int open);
/* Shades all pixels into haar->light and gloss, in (pixels / batch) batches of 3 passes a round and one
   more, or of one pass by compute. A round takes 16 of what the scene has: its entities, and each light
   three times more.
   eye      world, for gloss; NULL = that of the G-buffer, which knows it if it was drawn or imported
   open     not 0: light.a is wanted even if there is no sky; else it is 0 then
   Errors   GLBK_ERR_ARGUMENT: an object is NULL or was not created, or gloss is shaded and no eye is known.
            GLBK_ERR_MISMATCH: the scene has harmonics or other texels, was uploaded with another
            ctx->compute, or is not the one that self-visibility was named for, or the G-buffer has another
            size. GLBK_ERR_LOST */

GLBK_DEF void glbk_sfield_haar_free(glbk_context *ctx, glbk_sfield_haar *haar);
/* Deletes the renderer's objects of GL and zeroes the struct. Accepts NULL. */

/* ---- structs of page one ---- */

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

typedef struct glbk_sfield_haar_desc {
    uint32_t width;                     /* pixels, 1 .. ctx->max_side, like height */
    uint32_t height;
    uint32_t cube_side;                 /* that of the scene: a power of two, 4..64; 0 = 32 */
    uint32_t batch;                     /* points that are shaded at a time, at most so many as textures of
                                           2048 or ctx->max_side a side hold: 672 of cubes of 16, 168 of 32,
                                           40 of 64; by compute 2048. A greater number is taken for that; 0 =
                                           256, or 2048 by compute without gloss. More points make fewer
                                           passes */
    int      self;                      /* not 0: there is room for self-visibility, 4 bytes a pixel */
    int      gloss;                     /* not 0: gloss is shaded by Phong's lobe and by glTF's metal-rough
                                           BRDF, as each pixel's material says */
} glbk_sfield_haar_desc;
