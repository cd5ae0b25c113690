/* ---- page one: a scene of fields that lights the pixels of a G-buffer ---- */

typedef struct glbk_sfield_scene glbk_sfield_scene;         /* fields, entities: see "objects" below */
typedef struct glbk_sfield_renderer glbk_sfield_renderer;   /* the light of a picture: see there, too */
struct glbk_sfield_scene_desc;      /* which fields, how many entities: below */
struct glbk_sfield_renderer_desc;   /* how large the picture is: below */

GLBK_DEF glbk_result glbk_sfield_scene_create(glbk_context *ctx, const struct glbk_sfield_scene_desc *desc,
                                              glbk_sfield_scene *out);
/* Uploads fields, and makes room for entities. The scene is empty and its sky is black at first.
   Memory   on the GPU the fields, their coefficients filled up to a multiple of 16, and with desc.brdf 332 KB
            for 4 bands, 1 MB for 8; here 40 bytes a field and, while the call runs, the longest file of a
            field (sfield_bytes) and 16 KB
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range. GLBK_ERR_MISMATCH:
            a field of wavelets, self-visibility or other bands, a shard, or some occlusion fields of
            logarithms and some of others. GLBK_ERR_LIMIT: more than 2^28 texels. GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_sfield_scene_entities(glbk_context *ctx, glbk_sfield_scene *scene,
                                                const sfield_entity *entities, size_t count);
/* Says where all entities are now, as sfield_scene_entities does; entity 1 is entities[0]. Call it whenever
   one of them has moved or changed: the call uploads all of them, 112 bytes each and their rotations.
   count    0 .. scene->entity_capacity
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the scene was not created. GLBK_ERR_LIMIT: count is above
            entity_capacity. GLBK_ERR_INPUT: a transform, tint or time cannot be used. GLBK_ERR_MISMATCH: a
            field was not uploaded, or is of the other kind. The scene is as it was then. GLBK_ERR_ALLOC and
            GLBK_ERR_LOST: some entities may have moved */

GLBK_DEF glbk_result glbk_sfield_scene_sky(glbk_context *ctx, glbk_sfield_scene *scene, const float *coefs);
/* Sets the environment and its suns.
   coefs    3 bands^2 numbers from sfield_scene_sky; NULL = no sky
   Errors   GLBK_ERR_ARGUMENT: scene is NULL or was not created. GLBK_ERR_MISMATCH: it has wavelets */

GLBK_DEF glbk_result glbk_sfield_renderer_create(glbk_context *ctx,
                                                 const struct glbk_sfield_renderer_desc *desc,
                                                 glbk_sfield_renderer *out);
/* Compiles the program that shades and makes its textures.
   Memory   on the GPU 16 bytes a pixel, 16 more with gloss or materials, 16 more with grazing, and what
            desc.self takes
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range, algebra is NULL, or
            grazing is wanted without materials. GLBK_ERR_LIMIT: width or height is above ctx->max_side.
            GLBK_ERR_ALLOC. Those of textures, targets and glbk_program_compile */

GLBK_DEF glbk_result glbk_sfield_shade(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                       const glbk_gbuffer *gbuffer, const glbk_sfield_scene *scene,
                                       const float eye[3], int open);
/* Shades all pixels into renderer->light and gloss. Light is not clamped: ringing may take it below 0. The
   compute path finds entities for blocks of 8 x 8 pixels, so points near each other belong in one block.
   eye      world, for lobes; NULL = that of the G-buffer, which knows it if it was drawn or imported
   open     not 0: light.a is wanted even if there is no sky
   Errors   GLBK_ERR_ARGUMENT: an object is NULL or was not created, or the renderer shades lobes and no eye
            is known. GLBK_ERR_MISMATCH: the scene has wavelets, other bands, no BRDFs for desc.materials, or
            logarithms without desc.logarithms or none with it, or the G-buffer has another size.
            GLBK_ERR_LOST */

GLBK_DEF void glbk_sfield_scene_free(glbk_context *ctx, glbk_sfield_scene *scene);
/* Deletes the scene's objects of GL, frees its memory and zeroes the struct; the fields are yours. Accepts
   NULL. */

GLBK_DEF void glbk_sfield_renderer_free(glbk_context *ctx, glbk_sfield_renderer *renderer);
/* Deletes the renderer's objects of GL and zeroes the struct. Accepts NULL. */

/* ---- structs of page one ---- */

typedef struct glbk_sfield_scene_desc {
    const sfield_algebra      *algebra; /* of the fields' bands; the scene turns entities by it, so it must
                                           outlive the scene */
    const sfield_field *const *fields;  /* occlusion and source fields of harmonics, all of as many bands.
                                           Entities name them by these pointers, so they must outlive the
                                           scene */
    size_t   field_count;
    uint32_t entity_capacity;           /* the most entities, 1..65535 */
    float    reach;                     /* as in sfield_scene_desc: occluders count up to this many of their
                                           radii, to 1e6; 0 = to the outermost shell of each */
    const float *brdf;                  /* for renderers with desc.materials: what sfield_sh_brdf wrote for
                                           the bands of algebra, read until glbk_sfield_scene_create returns.
                                           NULL = no BRDFs */
} glbk_sfield_scene_desc;

typedef struct glbk_sfield_renderer_desc {
    uint32_t width;                     /* pixels, 1 .. ctx->max_side, like height */
    uint32_t height;
    const sfield_algebra *algebra;      /* required: of the scene's bands; it is read until
                                           glbk_sfield_renderer_create returns */
    int      gloss;                     /* not 0: lobes of the G-buffer's Phong materials are shaded, too */
    int      self;                      /* not 0: there is room for self-visibility, 32 bytes a pixel; for 5
                                           to 8 bands 64 to 128 */
    uint32_t self_attribute;            /* location of a mesh's first four coefficients of self-visibility;
                                           the next locations have the other coefficients; 1..12, 0 = 4 */
    int      product_in_table;          /* not 0: shaders read the terms of the product from the table, as
                                           from 5 bands on anyway. 0: they are written into the program, which
                                           takes longer to compile and runs several times as fast */
    int      materials;                 /* not 0: gloss is shaded by Phong's lobe and by glTF's metal-rough
                                           BRDF, as each pixel's material says; the scene has desc.brdf */
    int      grazing;                   /* not 0: renderer->grazing is wanted, too; only with materials */
    int      logarithms;                /* not 0: for scenes whose occlusion fields hold logarithms
                                           (sfield_desc.logarithm), as SFIELD_PRODUCT_EXP */
} glbk_sfield_renderer_desc;
