/* ---- sfield: shadow fields, after shadowfield.h ----

   The fields of a scene are uploaded once, into one table with what the product needs; entities and the sky are in
   another, so that moving them leaves fields alone. Fields, entities and what is recorded are shadowfield.h's, and so
   are the numbers of entities: they count from 1, 0 is none. A pixel of the G-buffer (gl_gbuffer.h) is any point to
   shade: one of the screen, or a vertex. Wavelets and fields of logarithms are shadowfield.h's alone. A frame:

       glbk_sfield_scene_entities(gl, &scene, entities, count);     // and glbk_sfield_scene_sky
       glbk_gbuffer_begin(gl, &gbuffer, world_to_clip, eye);        // or _import, or _upload
       glbk_sfield_self_begin(gl, &renderer, &gbuffer);             // what objects hide of themselves; or _self_upload
       glbk_sfield_shade(gl, &renderer, &gbuffer, &scene, eye, 0);  // renderer.light has the picture

   For shaders of your own, lib/sfield_shade.glsl with glbk_sfield_bind, SFIELD_BANDS defined:

       void sfield_cosine(vec3 n, out float t[SFIELD_COEFS]);
       sfield_sums sfield_shade(vec3 position, vec3 normal, uint own, float t[SFIELD_COEFS], float g[SFIELD_COEFS]);

   World space, normals unit; own: the entity that the point lies on, counted from 1, or 0; t: of sfield_cosine, or own
   visibility x cosine, turned into the world; g: t times Phong's lobe, read with SFIELD_GLOSS=1 alone. Result: light
   (rgb irradiance, W/m^2; times albedo / pi it is radiance), gloss, open (first coefficient of what stays visible). */

#define GLBK_SFIELD_TEXTURES(X)                                                                     \
    X(usampler2DArray, glbk_sfield_table, 0)    /* terms, fields */                                 \
    X(usampler2DArray, glbk_sfield_self, 3)     /* own visibility of a picture */                   \
    X(usampler2D, glbk_sfield_seen, 4)          /* building: samples; texels; integrals of the basis */ \
    X(usampler2D, glbk_sfield_cube, 5)                                                              \
    X(usampler2DArray, glbk_sfield_basis, 6)                                                        \
    X(usampler2DArray, glbk_sfield_moving, 7)   /* sky, entities, rotations */

#define GLBK_SFIELD_CONTENTS_MEMBERS(X)                                                             \
    X(uvec4, table, 1)          /* texel of the entities, count, lights; 1: go to the sky */        \
    X(uvec4, parts, 1)          /* texel of the terms, pairs of them; texel of the sky */

#define GLBK_SFIELD_FRAME_MEMBERS(X) X(vec4, eye, 1)

#define GLBK_SFIELD_OBJECT_MEMBERS(X)                                                               \
    X(mat4, world, 1)                                                                               \
    X(mat4, clip, 1)

#define GLBK_SFIELD_VIEWS_MEMBERS(X)                                                                \
    X(vec4, sphere, 1)          /* centre, radius */                                                \
    X(uvec4, how, 1)            /* first tile, tiles a column, samples a side of a tile, N */       \
    X(uvec4, size, 1)           /* eyes a batch, groups of four coefficients */                     \
    X(vec4, eyes, 256)          /* of each tile: in radii about the centre; 1 / greatest depth */   \
    X(uvec4, places, 256)       /* face, eye; column, row of the atlas */

#define GLBK_SFIELD_BLOCKS(X)                                                                       \
    X(glbk_sfield_contents, 0, GLBK_SFIELD_CONTENTS_MEMBERS)                                          \
    X(glbk_sfield_frame, 1, GLBK_SFIELD_FRAME_MEMBERS)                                              \
    X(glbk_sfield_object, 2, GLBK_SFIELD_OBJECT_MEMBERS)                                            \
    X(glbk_sfield_views, 3, GLBK_SFIELD_VIEWS_MEMBERS)

#define GLBK_SFIELD_STORAGE(X)
#define GLBK_SFIELD_IMAGES(X)                                                                       \
    X(writeonly, rgba32f, image2D, glbk_sfield_light_image, 0)                                      \
    X(writeonly, rgba32f, image2D, glbk_sfield_gloss_image, 1)                                      \
    X(writeonly, rgba32ui, uimage2D, glbk_sfield_cube_image, 2) /* building */                      \
    X(writeonly, rgba32ui, uimage2D, glbk_sfield_coefs_image, 3)

GLBK__PART(SFIELD)

GLBK_DEF const glbk_part *glbk_sfield_part(void);
/* The GLSL of this header, for programs of your own that use its library files: glbk_source.parts. */

typedef struct glbk_sfield_scene_desc {
    const sfield_algebra *algebra;      /* of the fields' bands; must outlive the scene, which turns entities by it */
    const sfield_field *const *fields;  /* occlusion and source fields of harmonics, as many bands; entities name them
                                           by these pointers, so they must outlive the scene */
    size_t                field_count;
    uint32_t              entity_capacity;      /* most entities, 1..65535 */
    float                 reach;        /* as in sfield_scene_desc: occluders count up to this many radii, to 1e6; 0 =
                                           the outermost shell of each */
} glbk_sfield_scene_desc;

typedef struct glbk_sfield_field {      /* read only: a field in the table */
    const sfield_field *field;
    uint32_t start;                     /* its first texel: what sfield_locate() and sfield_fetch() take */
    int      source;
    float    center[3], radius, inscribed, outer;       /* in its own space; outer in radii */
} glbk_sfield_field;

typedef struct glbk_sfield_scene {      /* read only; zeroed = none */
    glbk_texture table, moving;         /* terms and fields; sky, entities, rotations */
    glbk_buffer  contents;
    uint32_t     bands, entity_capacity, entity_count, light_count;
    glbk_sfield_field *fields;          /* by their pointers, rising */
    size_t       field_count;
    uint32_t     terms, texels, entities_at;            /* texels: of the table */
    int          sky;
    float        reach;
    const sfield_algebra *algebra;
} glbk_sfield_scene;

GLBK_DEF glbk_result glbk_sfield_scene_create(glbk_context *ctx, const glbk_sfield_scene_desc *desc,
                                              glbk_sfield_scene *out);
/* Uploads fields; nothing is placed yet, and the sky is black.
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_DESC; GLBK_ERR_MISMATCH: a field of wavelets, logarithms, self-visibility or
            other bands, or a shard; GLBK_ERR_LIMIT: more than 2^28 texels; GLBK_ERR_ALLOC
   Memory   on the GPU the fields, with coefficients filled up to a multiple of 16; here 56 bytes a field and, while it
            runs, the longest file of a field (sfield_bytes) and 16 KB */
GLBK_DEF void glbk_sfield_scene_free(glbk_context *ctx, glbk_sfield_scene *scene);

GLBK_DEF glbk_result glbk_sfield_scene_entities(glbk_context *ctx, glbk_sfield_scene *scene,
                                                const sfield_entity *entities, size_t count);
/* Where everything is now: what sfield_scene_entities takes. Entity 1 is entities[0].
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_LIMIT (more than entity_capacity); GLBK_ERR_INPUT (a transform, tint or time);
            GLBK_ERR_MISMATCH (a field that was not uploaded, an occlusion in place of a source): nothing has changed
            then. GLBK_ERR_ALLOC, GLBK_ERR_LOST: some of them may have moved */
GLBK_DEF glbk_result glbk_sfield_scene_sky(glbk_context *ctx, glbk_sfield_scene *scene, const float *coefs);
/* Environment and suns: 3 bands^2 coefficients from sfield_scene_sky; NULL = none. */
GLBK_DEF void glbk_sfield_bind(glbk_context *ctx, const glbk_sfield_scene *scene, const glbk_offset *offset);
/* For your own program with sfield_shade.glsl: compile it with SFIELD_BANDS=scene.bands.
   offset   that sfield has in the program; NULL = none */

typedef struct glbk_sfield_renderer_desc {
    uint32_t              width, height;
    const sfield_algebra *algebra;      /* of the scene's bands; read until glbk_sfield_renderer_create returns */
    int                   gloss;        /* not 0: Phong lobes too, of the G-buffer's Phong materials */
    int                   self;         /* not 0: room for own visibility, 32 bytes a pixel; 5 to 8 bands: 64 to 128 */
    uint32_t              self_attribute;       /* location of a mesh's first four coefficients of own visibility; the
                                                   others follow. 1..12; 0 = 4 */
    int                   product_in_table;     /* not 0: shaders read the product's terms from the table, as from 5
                                                   bands on anyway; 0: they are written into the program, which
                                                   compiles slower and runs several times as fast */
} glbk_sfield_renderer_desc;

typedef struct glbk_sfield_renderer {   /* read only; zeroed = none */
    glbk_texture light, gloss;          /* GLBK_FORMAT_COLOR. light: rgb to multiply by albedo, a: the open share of the
                                           cosine-weighted sphere. gloss: rgb to multiply by the specular colour */
    glbk_texture self;                  /* own visibility */
    glbk_target  target, self_target;
    glbk_program shade, record;
    glbk_buffer  frame, object;
    uint32_t     width, height, bands, self_attribute;
    int          compute;
    int32_t      position_attribute;    /* that record was compiled for */
    float        clip[16];              /* of glbk_sfield_self_begin */
} glbk_sfield_renderer;

GLBK_DEF size_t glbk_sfield_write_product(const sfield_algebra *algebra, char *out, size_t out_bytes);
/* sfield_product with its numbers in it, for a program that defines SFIELD_UNROLLED: its text goes after "sfield_access
   sfield_field" and before lib/sfield_shade.glsl.
   out      receives it, cut to so many bytes and ended by 0; may be NULL with out_bytes 0
   Returns the bytes needed with the 0, or 0 without an algebra and for more than 4 bands, which do not gain by it. */

GLBK_DEF glbk_result glbk_sfield_renderer_create(glbk_context *ctx, const glbk_sfield_renderer_desc *desc,
                                                 glbk_sfield_renderer *out);
GLBK_DEF void glbk_sfield_renderer_free(glbk_context *ctx, glbk_sfield_renderer *renderer);

GLBK_DEF glbk_result glbk_sfield_shade(glbk_context *ctx, glbk_sfield_renderer *renderer, const glbk_gbuffer *gbuffer,
                                       const glbk_sfield_scene *scene, const float eye[3], int open);
/* Direct light at all pixels into renderer->light and gloss. The compute path finds entities for 8 x 8 pixels together:
   points near each other belong in one such block.
   eye      for lobes; NULL = that of the G-buffer, which knows it where it was drawn or imported
   open     not 0 = light.a is wanted even where there is no sky
   Not clamped: ringing may go below 0.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_MISMATCH (a scene of other bands, a G-buffer of another size), GLBK_ERR_LOST */
GLBK_DEF glbk_result glbk_sfield_read(glbk_context *ctx, glbk_sfield_renderer *renderer, float *light, float *gloss);
/* 4 floats a pixel each, or NULL. Waits for the GPU. Errors GLBK_ERR_MISMATCH: gloss of a renderer without it */

/* ---- sfield: own visibility, what a point's own object hides ----

   sfield_build_self records it for the vertices of a mesh. Pixels of which nothing was given start with the cosine. It
   is in the space of the entity that the G-buffer names, and turns with it. Renderers with desc.self alone have it; it
   stays from frame to frame until it is given anew. */

GLBK_DEF glbk_result glbk_sfield_self_begin(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                            const glbk_gbuffer *gbuffer);
/* Forgets it at all pixels and binds a target with a program, to draw it on what was drawn into the G-buffer, whose
   depth and matrix count. The program is compiled at first use.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_ORDER: the G-buffer was not drawn; GLBK_ERR_LIMIT: more than 4 bands;
            GLBK_ERR_MISMATCH: a renderer without desc.self, a G-buffer of another size, an attribute at two places */
GLBK_DEF glbk_result glbk_sfield_self_object(glbk_context *ctx, glbk_sfield_renderer *renderer, const float world[16]);
/* Then draw the object from your vertex array: its position where the G-buffer has it, four coefficients each from
   desc.self_attribute on.
   world    that of its glbk_surface, so that depths are equal; zeros = identity */
GLBK_DEF glbk_result glbk_sfield_self_upload(glbk_context *ctx, glbk_sfield_renderer *renderer, uint32_t row,
                                             uint32_t row_count, const float *const *self);
/* Whole rows from the CPU: of each pixel bands^2 coefficients from sfield_self, mixed as you like, or NULL = nothing is
   known. They are kept with 16 bits, to 5e-5. Errors GLBK_ERR_ARGUMENT, GLBK_ERR_MISMATCH as above, GLBK_ERR_ALLOC */

/* ---- sfield: building on the GPU ----

   Draws what is seen from the sample points of a field, up to 256 faces of cubes at a time in one atlas, counts samples
   into texels and projects these on harmonics. shadowfield.h asks for it and makes the field:

       int see(void *user, const sfield_views *views)
       {
           return glbk_sfield_builder_see(gl, &builder, views) != GLBK_OK;
       }
       ... sfield_build_views(&desc, 0, &mesh, see, NULL, &field, NULL); */

typedef void (*glbk_sfield_draw_fn)(void *user, glbk_context *ctx, int32_t instances);
/* Draws your object, within the sphere: bind its vertex array, attribute 0 the position in the field's space, sources:
   attribute 1 the radiance of the triangle, and draw so many instances; program and state are ours. */

typedef struct glbk_sfield_builder_desc {
    const sfield_desc  *field;      /* the desc that sfield_build_views gets: its basis, bands and cube_side say what is
                                       projected; NULL = its defaults */
    const sfield_mesh  *mesh;       /* in the field's space; NULL = draw_fn */
    int                 source;     /* not 0: radiance, else alpha */
    const float        *radiance;   /* sources: r, g, b of each triangle of mesh, 0..1e18; other frames by draw_fn */
    glbk_sfield_draw_fn draw_fn;    /* used without a mesh */
    void               *user;
} glbk_sfield_builder_desc;         /* all is kept by you until glbk_sfield_builder_create returns */

typedef struct glbk_sfield_builder {    /* batch: most eyes of which cubes are kept at once. The rest is private */
    uint32_t      batch, side, bands, groups, height;
    int           source;
    glbk_sfield_draw_fn draw_fn;
    void         *user;
    float         center[3], radius;    /* of your mesh */
    uint32_t      vertex_array, index_count;
    glbk_buffer   vertices, indices, block;
    glbk_texture  seen, depth, cube, coefs, basis;
    glbk_target   seen_target, cube_target, coef_target;
    glbk_program  see, sum, project;
    glbk_sfield_views *views;
    uint32_t     *words;                /* what was read back */
    int           compute;
} glbk_sfield_builder;

GLBK_DEF glbk_result glbk_sfield_builder_create(glbk_context *ctx, const glbk_sfield_builder_desc *desc,
                                                glbk_sfield_builder *out);
GLBK_DEF glbk_result glbk_sfield_builder_see(glbk_context *ctx, glbk_sfield_builder *builder,
                                             const sfield_views *views);
GLBK_DEF void glbk_sfield_builder_free(glbk_context *ctx, glbk_sfield_builder *builder);
/* see       writes views->values. Samples as sfield_build takes them: 64 to 512 a side of a face (sources 256), by
             distance
   Memory    on the GPU 4 MB (sources 20), cubes of a batch, the mesh, bands^2 x 24 N^2 bytes; here what is read back of
             a batch. In glbk_sfield_builder_create once more the mesh, or the basis
   Errors    GLBK_ERR_ARGUMENT, GLBK_ERR_DESC; GLBK_ERR_INPUT (what sfield_build refuses of a mesh; radiance or views
             that are not finite), GLBK_ERR_ALLOC, GLBK_ERR_LIMIT; `values` may be half written. No float targets are
             needed */

