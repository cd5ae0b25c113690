/* ---- sfield: shadow fields, after shadowfield.h ----

   The fields of a scene are uploaded once, into one table, with the terms of the product; entities and the
   sky stand in another one, so that moving them leaves the fields alone. Fields, entities and what is
   recorded are shadowfield.h's, and so are the numbers of entities: they count from 1, 0 is none. The points
   that are shaded are the pixels of a G-buffer (gl_gbuffer.h): of the screen, or vertices. A frame:

       glbk_sfield_scene_entities(gl, &scene, entities, count);     // where all is; and glbk_sfield_scene_sky
       glbk_gbuffer_begin(gl, &gbuffer, world_to_clip, eye);        // or _import, or _upload
       glbk_gbuffer_object(gl, &gbuffer, &surface);                 // for each object, with your draw
       glbk_sfield_shade(gl, &renderer, &gbuffer, &scene, eye, 0);

   renderer.light then holds the light at each pixel without the surface's colour. There is no function that
   resolves it to a picture, as those of other techniques do, since how light meets colour is your lighting
   pass's matter; it is one line: albedo times light.rgb, and specular colour times gloss.rgb.

   Shaders of your own call lib/sfield_shade.glsl, after glbk_sfield_bind, with SFIELD_BANDS defined:

       void sfield_cosine(vec3 n, out float t[SFIELD_COEFS]);
       sfield_sums sfield_shade(vec3 position, vec3 normal, uint own, float t[SFIELD_COEFS],
                                float g[SFIELD_COEFS]);

       position, normal   world space; the normal is unit
       own                the entity that the point lies on, counted from 1; 0 = none
       t                  from sfield_cosine, or own visibility x cosine, turned into the world
       g                  t times Phong's lobe; it is read with SFIELD_GLOSS=1 alone

   The result has light (irradiance, W/m^2; times albedo / pi it is radiance), gloss, and open, the first
   coefficient of what stays visible. */

GLBK_DEF const glbk_part *glbk_sfield_part(void);
/* Returns the GLSL of this header, for glbk_source.parts of a program of yours that uses its library
   files. */

typedef struct glbk_sfield_scene_desc {
    const sfield_algebra      *algebra; /* of the fields' bands; the scene turns entities by it, so it must
                                           outlive it */
    const sfield_field *const *fields;  /* occlusion and source fields of harmonics, all of as many bands.
                                           Entities name them by these pointers, so they must outlive the
                                           scene */
    size_t   field_count;
    uint32_t entity_capacity;           /* the most entities, 1..65535 */
    float    reach;                     /* as in sfield_scene_desc: occluders count up to this many of their
                                           radii, to 1e6; 0 = to the outermost shell of each */
} glbk_sfield_scene_desc;

typedef struct glbk_sfield_field {      /* a field in the table; read only */
    const sfield_field *field;
    uint32_t start;                     /* its first texel: what sfield_locate() and sfield_fetch() take */
    int      source;                    /* not 0: a source, else an occlusion field */
    float    center[3];                 /* in its own space */
    float    radius;
    float    inscribed;                 /* radius of the inscribed sphere */
    float    outer;                     /* the outermost shell, in radii */
} glbk_sfield_field;

typedef struct glbk_sfield_scene {      /* read only; zeroed = none */
    glbk_texture table;                 /* terms and fields */
    glbk_texture moving;                /* the sky, entities, rotations */
    glbk_buffer  contents;              /* the uniform block */
    uint32_t     bands;
    uint32_t     entity_capacity;
    uint32_t     entity_count;
    uint32_t     light_count;           /* entities that shine */
    glbk_sfield_field *fields;          /* in the order of their pointers */
    size_t       field_count;
    uint32_t     terms;                 /* private, like all that follows: texels of the terms */
    uint32_t     texels;                /* of the table */
    uint32_t     entities_at;           /* where they begin */
    int          sky;                   /* not 0: there is one */
    float        reach;
    const sfield_algebra *algebra;
} glbk_sfield_scene;

GLBK_DEF glbk_result glbk_sfield_scene_create(glbk_context *ctx, const glbk_sfield_scene_desc *desc,
                                              glbk_sfield_scene *out);
/* Uploads fields, and makes room for entities. Nothing is placed yet, and the sky is black.
   Memory   on the GPU the fields, their coefficients filled up to a multiple of 16; here 56 bytes a field
            and, while it runs, the longest file of a field (sfield_bytes) and 16 KB
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC: a number is out of range; GLBK_ERR_MISMATCH: a field of
            wavelets, logarithms, own visibility or other bands, or a shard; GLBK_ERR_LIMIT: more than 2^28
            texels; GLBK_ERR_ALLOC */

GLBK_DEF void glbk_sfield_scene_free(glbk_context *ctx, glbk_sfield_scene *scene);
/* Deletes the scene's objects of GL, frees its memory and zeroes the struct; the fields are yours. Accepts
   NULL. */

GLBK_DEF glbk_result glbk_sfield_scene_entities(glbk_context *ctx, glbk_sfield_scene *scene,
                                                const sfield_entity *entities, size_t count);
/* Says where all entities are now, as sfield_scene_entities does; entity 1 is entities[0]. Call it whenever
   one of them has moved or changed: it uploads all of them, 112 bytes each and their rotations.
   count    0 .. scene->entity_capacity
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_LIMIT: more than entity_capacity; GLBK_ERR_INPUT: a transform, tint or
            time is not usable; GLBK_ERR_MISMATCH: a field was not uploaded, or is of the other kind. Nothing
            has changed then. After GLBK_ERR_ALLOC and GLBK_ERR_LOST some of them may have moved */

GLBK_DEF glbk_result glbk_sfield_scene_sky(glbk_context *ctx, glbk_sfield_scene *scene, const float *coefs);
/* Sets the environment and its suns.
   coefs    3 bands^2 numbers from sfield_scene_sky; NULL = no sky
   Errors   GLBK_ERR_ARGUMENT */

GLBK_DEF void glbk_sfield_bind(glbk_context *ctx, const glbk_sfield_scene *scene, const glbk_offset *offset);
/* Binds the scene for a program of yours that uses lib/sfield_shade.glsl and is bound (glbk_begin). The
   program is compiled with SFIELD_BANDS=n, n being scene->bands.
   offset   what glbk_source.offsets gives this part in the program; NULL = none */

GLBK_DEF size_t glbk_sfield_write_product(const sfield_algebra *algebra, char *out, size_t out_bytes);
/* Writes the GLSL function sfield_product with its numbers in it, which runs several times as fast as the one
   that reads them from the table. It is for a program that defines SFIELD_UNROLLED, and goes behind
   lib/sfield_access.glsl and lib/sfield_field.glsl and before lib/sfield_shade.glsl. It needs no context.
   out      receives the text, cut to out_bytes and ended by 0; it may be NULL with out_bytes 0
   Returns the bytes needed with the 0, or 0 without an algebra and for more than 4 bands, which do not gain
   by it. */

/* ---- sfield: shading a G-buffer ---- */

typedef struct glbk_sfield_renderer_desc {
    uint32_t width;                     /* pixels, 1 .. ctx->max_side, like height */
    uint32_t height;
    const sfield_algebra *algebra;      /* of the scene's bands; it is read until glbk_sfield_renderer_create
                                           returns */
    int      gloss;                     /* not 0: lobes of the G-buffer's Phong materials are shaded, too */
    int      self;                      /* not 0: there is room for own visibility, 32 bytes a pixel; for 5 to
                                           8 bands 64 to 128 */
    uint32_t self_attribute;            /* location of a mesh's first four coefficients of own visibility,
                                           which those of the others follow; 1..12, 0 = 4 */
    int      product_in_table;          /* not 0: shaders read the terms of the product from the table, as
                                           from 5 bands on anyway. 0: they are written into the program, which
                                           takes longer to compile and runs several times as fast */
} glbk_sfield_renderer_desc;

typedef struct glbk_sfield_renderer {   /* read only; zeroed = none */
    glbk_texture light;                 /* GLBK_FORMAT_COLOR: rgb times albedo is radiance; a is the open
                                           share of the cosine-weighted sphere */
    glbk_texture gloss;                 /* rgb times the specular colour is radiance; none without
                                           desc.gloss */
    glbk_texture self;                  /* own visibility; none without desc.self */
    glbk_target  target;                /* light and gloss */
    glbk_target  self_target;           /* private, like all that follows but width, height and compute */
    glbk_program shade;
    glbk_program record;
    glbk_buffer  frame;
    glbk_buffer  object;
    uint32_t     width;
    uint32_t     height;
    uint32_t     bands;
    uint32_t     self_attribute;
    int          compute;               /* not 0: it shades by a compute shader */
    int32_t      position_attribute;    /* the one that record was compiled for */
    float        clip[16];              /* of glbk_sfield_self_begin */
} glbk_sfield_renderer;

GLBK_DEF glbk_result glbk_sfield_renderer_create(glbk_context *ctx, const glbk_sfield_renderer_desc *desc,
                                                 glbk_sfield_renderer *out);
/* Compiles the program that shades and makes its textures.
   Memory   on the GPU 16 bytes a pixel, 16 more with gloss, and own visibility
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC: a number is out of range; GLBK_ERR_ALLOC; those of textures,
            targets and glbk_program_compile */

GLBK_DEF void glbk_sfield_renderer_free(glbk_context *ctx, glbk_sfield_renderer *renderer);
/* Deletes the renderer's objects of GL and zeroes the struct. Accepts NULL. */

GLBK_DEF glbk_result glbk_sfield_shade(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                       const glbk_gbuffer *gbuffer, const glbk_sfield_scene *scene,
                                       const float eye[3], int open);
/* Shades all pixels into renderer->light and gloss. Light is not clamped: ringing may take it below 0. The
   compute path finds entities for blocks of 8 x 8 pixels, so points near each other belong in one block.
   eye      world, for lobes; NULL = that of the G-buffer, which knows it if it was drawn or imported
   open     not 0: light.a is wanted even if there is no sky
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_MISMATCH: the scene has other bands, or the G-buffer another size;
            GLBK_ERR_LOST */

GLBK_DEF glbk_result glbk_sfield_read(glbk_context *ctx, glbk_sfield_renderer *renderer, float *light,
                                      float *gloss);
/* Waits for the GPU and reads the light of all pixels, as the textures hold it, rows from the bottom up.
   light, gloss   receive 4 floats a pixel each; NULL = not wanted
   Errors         GLBK_ERR_ARGUMENT; GLBK_ERR_MISMATCH: gloss of a renderer without it; those of
                  glbk_target_read */

/* ---- sfield: own visibility, which is what a point's own object leaves open ----

   Fields say what other objects hide of a point; what its own object hides is recorded for the vertices of
   its mesh, by sfield_build_self, as visibility x cosine. A renderer with desc.self has room for it, and
   keeps it from frame to frame until it is given anew; pixels without it take the cosine. It is in the space
   of the entity that the G-buffer names there, and turns with it. Behind the draws of the G-buffer:

       glbk_sfield_self_begin(gl, &renderer, &gbuffer);
       glbk_sfield_self_object(gl, &renderer, surface.world);   // for each object with it, and your draw */

GLBK_DEF glbk_result glbk_sfield_self_begin(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                            const glbk_gbuffer *gbuffer);
/* Forgets own visibility at all pixels and binds what draws it anew, onto what was drawn into the G-buffer,
   whose depth and matrix it uses. The first call compiles a program.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_ORDER: the G-buffer was not drawn; GLBK_ERR_LIMIT: more than 4 bands;
            GLBK_ERR_MISMATCH: the renderer has no desc.self, the G-buffer another size, or an attribute two
            places */

GLBK_DEF glbk_result glbk_sfield_self_object(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                             const float world[16]);
/* Makes the draws that follow those of one object: bind its vertex array and draw. The array has the position
   where the G-buffer has it, and four coefficients each in the attributes from desc.self_attribute on.
   world    that of its glbk_surface, so that depths are equal; zeros = identity
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_MISMATCH: no desc.self; GLBK_ERR_ORDER: glbk_sfield_self_begin has not
            been called */

GLBK_DEF glbk_result glbk_sfield_self_upload(glbk_context *ctx, glbk_sfield_renderer *renderer, uint32_t row,
                                             uint32_t row_count, const float *const *self);
/* Writes own visibility of whole rows of pixels from memory, for a G-buffer that was uploaded. It is kept
   with 16 bits, off by 5e-5.
   self     renderer->width x row_count pointers: bands^2 coefficients from sfield_self, mixed as you like, or
            NULL where nothing is known
   Errors   GLBK_ERR_ARGUMENT: NULL, or rows beyond height; GLBK_ERR_MISMATCH: no desc.self; GLBK_ERR_ALLOC */

/* ---- sfield: building on the GPU ----

   A builder draws what is seen from the sample points of a field, up to 256 faces of cubes at a time in one
   atlas, counts samples into texels and projects these on harmonics. shadowfield.h asks for it and makes the
   field:

       int see(void *user, const sfield_views *views)
       {
           return glbk_sfield_builder_see(gl, &builder, views) != GLBK_OK;
       }
       ... sfield_build_views(&desc, 0, &mesh, see, NULL, &field, NULL); */

typedef void (*glbk_sfield_draw_fn)(void *user, glbk_context *ctx, int32_t instances);
/* Draws so many instances of your object, which lies within the field's sphere: it binds a vertex array with
   the position in the field's space as attribute 0 and, for sources, the radiance of the triangle as
   attribute 1. It changes neither program nor state. */

typedef struct glbk_sfield_builder_desc {
    const sfield_desc  *field;      /* the desc that sfield_build_views gets: its basis, bands and cube_side
                                       say what is projected. NULL = its defaults */
    const sfield_mesh  *mesh;       /* the object in the field's space; NULL = draw_fn draws it */
    int                 source;     /* not 0: radiance is built, else alpha */
    const float        *radiance;   /* sources: r, g, b of each triangle of mesh, 0..1e18, which is one frame;
                                       draw_fn draws others */
    glbk_sfield_draw_fn draw_fn;    /* used without a mesh */
    void               *user;       /* given to draw_fn */
} glbk_sfield_builder_desc;         /* keep all of it until glbk_sfield_builder_create returns */

typedef struct glbk_sfield_builder {    /* read only; zeroed = none */
    uint32_t      batch;                /* the most eyes of which cubes are kept at once */
    uint32_t      side;                 /* private, like all that follows: texels a side of a face */
    uint32_t      bands;                /* 0: texels are wanted, not coefficients */
    uint32_t      groups;               /* of four coefficients */
    uint32_t      height;               /* pixels of the atlas */
    int           source;
    glbk_sfield_draw_fn draw_fn;
    void         *user;
    float         center[3];            /* sphere round your mesh */
    float         radius;
    uint32_t      vertex_array;
    uint32_t      index_count;
    glbk_buffer   vertices;
    glbk_buffer   indices;
    glbk_buffer   block;
    glbk_texture  seen;                 /* the atlas */
    glbk_texture  depth;
    glbk_texture  cube;
    glbk_texture  coefs;
    glbk_texture  basis;                /* what it integrates to over texels */
    glbk_target   seen_target;
    glbk_target   cube_target;
    glbk_target   coef_target;
    glbk_program  see;
    glbk_program  sum;
    glbk_program  project;
    struct glbk_sfield_views *views;    /* the block's values */
    uint32_t     *words;                /* what was read back */
    int           compute;
} glbk_sfield_builder;

GLBK_DEF glbk_result glbk_sfield_builder_create(glbk_context *ctx, const glbk_sfield_builder_desc *desc,
                                                glbk_sfield_builder *out);
/* Makes a builder for one object.
   Memory   on the GPU 4 MB (sources 20), cubes of a batch, the mesh, and bands^2 x 24 side^2 bytes; here what
            is read back of a batch, and while it runs the mesh or the basis
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC: a number is out of range; GLBK_ERR_INPUT: what sfield_build
            refuses of a mesh, or radiance that is out of range; GLBK_ERR_ALLOC; those of textures and
            glbk_program_compile */

GLBK_DEF glbk_result glbk_sfield_builder_see(glbk_context *ctx, glbk_sfield_builder *builder,
                                             const sfield_views *views);
/* Draws what is seen from all eyes of views, writes it to views->values and waits for the GPU. Samples are
   those of sfield_build: 64 to 512 a side of a face (sources 256), by distance. No float targets are needed.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_INPUT: views are not finite; those of glbk_begin and of reading.
            values may be half written then */

GLBK_DEF void glbk_sfield_builder_free(glbk_context *ctx, glbk_sfield_builder *builder);
/* Deletes the builder's objects of GL, frees its memory and zeroes the struct. Accepts NULL. */
