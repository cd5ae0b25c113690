/* ---- the light of a picture ---- */

GLBK_DEF glbk_result glbk_sfield_read(glbk_context *ctx, glbk_sfield_renderer *renderer, float *light,
                                      float *gloss);
/* Waits for the GPU and reads the light of all pixels, as the textures hold it, rows from the bottom up.
   light, gloss   receive 4 floats a pixel each; NULL = not wanted
   Errors         GLBK_ERR_ARGUMENT: renderer is NULL or was not created. GLBK_ERR_MISMATCH: gloss is asked of
                  a renderer without it. Those of glbk_target_read */

/* ---- shaders of your own ---- */

GLBK_DEF const glbk_part *glbk_sfield_part(void);
/* Returns the GLSL of this header, for programs of your own that use its library files: see
   glbk_source.parts. */

GLBK_DEF void glbk_sfield_bind(glbk_context *ctx, const glbk_sfield_scene *scene, const glbk_offset *offset);
/* Binds the scene for a program of yours that uses lib/sfield_shade.glsl and is bound (glbk_begin). The
   program is compiled with SFIELD_BANDS=n, n being scene->bands.
   offset   the offset that glbk_source.offsets gives this part in the program; NULL = none */

GLBK_DEF size_t glbk_sfield_write_product(const sfield_algebra *algebra, char *out, size_t out_bytes);
/* Writes the GLSL function sfield_product with its numbers in the text, which runs several times as fast as
   the function that reads them from the table. The text is for a program that defines SFIELD_UNROLLED, and
   goes behind lib/sfield_access.glsl and lib/sfield_field.glsl and before lib/sfield_shade.glsl. The call
   needs no context and has no log.
   out      receives the text, cut to out_bytes and ended by 0; it may be NULL with out_bytes 0
   Returns the bytes needed with the 0, or 0 without an algebra and for more than 4 bands, which do not gain
   by it. */

/* ---- own visibility: what a point's own object leaves open ----

   Fields say what other objects hide of a point; what its own object hides is recorded for the vertices of
   its mesh, by sfield_build_self, as visibility x cosine. A renderer with desc.self has room for own
   visibility, and keeps it from frame to frame until it is given anew; pixels without it take the cosine. Own
   visibility is in the space of the entity that the G-buffer names there, and turns with the entity. Behind
   the draws of the G-buffer come these:

       glbk_sfield_self_begin(gl, &renderer, &gbuffer);
       glbk_sfield_self_object(gl, &renderer, surface.world);   // for each object with it, and your draw */

GLBK_DEF glbk_result glbk_sfield_self_begin(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                            const glbk_gbuffer *gbuffer);
/* Forgets own visibility at all pixels and begins a pass that draws it anew, at the places that were drawn
   into the G-buffer, whose depth and matrix the pass uses. The first call compiles a program.
   Errors   GLBK_ERR_ARGUMENT: an object is NULL or was not created. GLBK_ERR_ORDER: the G-buffer was not
            drawn. GLBK_ERR_LIMIT: more than 4 bands. GLBK_ERR_MISMATCH: the renderer has no desc.self, the
            G-buffer another size, or an attribute two places. Those of glbk_program_compile */

GLBK_DEF glbk_result glbk_sfield_self_object(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                             const float world[16]);
/* Says which object the next draws are of: bind its vertex array and draw. The array has the position in the
   attribute of the G-buffer, and four coefficients each in the attributes from desc.self_attribute on.
   world    that of its glbk_surface, so that depths are equal; zeros = identity
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or renderer was not created. GLBK_ERR_MISMATCH: the renderer
            has no desc.self. GLBK_ERR_ORDER: glbk_sfield_self_begin has not been called */

GLBK_DEF glbk_result glbk_sfield_self_upload(glbk_context *ctx, glbk_sfield_renderer *renderer, uint32_t row,
                                             uint32_t row_count, const float *const *self);
/* Writes own visibility of whole rows of pixels from memory, for a G-buffer that was uploaded. Coefficients
   are kept with 16 bits, off by 5e-5.
   self     renderer->width x row_count pointers: bands^2 coefficients from sfield_self, mixed as you like, or
            NULL where nothing is known
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, renderer was not created, or rows reach beyond height.
            GLBK_ERR_MISMATCH: the renderer has no desc.self. GLBK_ERR_ALLOC */

/* ---- building on the GPU ----

   A builder draws the object as seen from the sample points of a field, up to 256 faces of cubes at a time in
   one atlas, counts samples into texels and projects these on harmonics. shadowfield.h asks for the samples
   and makes the field:

       int see(void *user, const sfield_views *views)
       {
           return glbk_sfield_builder_see(gl, &builder, views) != GLBK_OK;
       }
       ... sfield_build_views(&desc, 0, &mesh, see, NULL, &field, NULL); */

typedef void (*glbk_sfield_draw_fn)(void *user, glbk_context *ctx, int32_t instances);
/* Draws so many instances of your object, which lies within the field's sphere. The function binds a vertex
   array with the position in the field's space as attribute 0 and, for sources, the radiance of the triangle
   as attribute 1. It must change neither program nor state. */

typedef struct glbk_sfield_builder glbk_sfield_builder; /* see "objects" below */

typedef struct glbk_sfield_builder_desc {
    const sfield_desc  *field;      /* the desc that sfield_build_views gets: its basis, bands and cube_side
                                       tell the projection. NULL = all defaults */
    const sfield_mesh  *mesh;       /* the object in the field's space; NULL = draw_fn draws it */
    int                 source;     /* not 0: radiance is built, else alpha */
    const float        *radiance;   /* sources: r, g, b of each triangle of mesh, 0..1e18, which is one frame;
                                       draw_fn draws others */
    glbk_sfield_draw_fn draw_fn;    /* used without a mesh */
    void               *user;       /* given to draw_fn */
} glbk_sfield_builder_desc;         /* keep all of it until glbk_sfield_builder_create returns */

GLBK_DEF glbk_result glbk_sfield_builder_create(glbk_context *ctx, const glbk_sfield_builder_desc *desc,
                                                glbk_sfield_builder *out);
/* Makes a builder for one object.
   Memory   on the GPU 4 MB (sources 20), cubes of a batch, the mesh, and bands^2 x 24 side^2 bytes; here the
            numbers that are read back of a batch, and while the call runs the mesh or the basis
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a number is out of range. GLBK_ERR_INPUT: a
            mesh that sfield_build refuses, or radiance that is out of range. GLBK_ERR_ALLOC. Those of
            textures and glbk_program_compile */

GLBK_DEF glbk_result glbk_sfield_builder_see(glbk_context *ctx, glbk_sfield_builder *builder,
                                             const sfield_views *views);
/* Draws the faces of cubes round all eyes of views, writes views->values and waits for the GPU. Samples are
   those of sfield_build: 64 to 512 a side of a face (sources 256), by distance. No float targets are needed.
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, the builder was not created, or views->count is 0.
            GLBK_ERR_INPUT: views are not finite. Those of glbk_begin and of reading, after which values may
            be half written */

GLBK_DEF void glbk_sfield_builder_free(glbk_context *ctx, glbk_sfield_builder *builder);
/* Deletes the builder's objects of GL, frees its memory and zeroes the struct. Accepts NULL. */

/* ---- objects: read only ---- */

typedef struct glbk_sfield_field {      /* a field in the table; read only */
    const sfield_field *field;
    uint32_t start;                     /* its first texel, for sfield_locate() and sfield_fetch() */
    int      source;                    /* not 0: a source, else an occlusion field */
    float    center[3];                 /* in the field's own space */
    float    radius;
    float    inscribed;                 /* radius of the inscribed sphere */
    float    outer;                     /* the outermost shell, in radii */
} glbk_sfield_field;

struct glbk_sfield_scene {              /* fields and where they stand; read only; zeroed = none */
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
    uint32_t     texels;                /* texels of the table */
    uint32_t     entities_at;           /* the texel of moving at which entities begin */
    int          sky;                   /* not 0: there is a sky */
    float        reach;
    const sfield_algebra *algebra;
};

struct glbk_sfield_renderer {           /* the light of a picture; read only; zeroed = none */
    glbk_texture light;                 /* GLBK_FORMAT_COLOR: rgb times albedo is radiance; a is the open
                                           share of the cosine-weighted sphere */
    glbk_texture gloss;                 /* rgb times the specular colour is radiance; none without
                                           desc.gloss */
    glbk_texture self;                  /* own visibility; none without desc.self */
    glbk_target  target;                /* of light and gloss */
    glbk_target  self_target;           /* private, like all that follows but width, height and compute */
    glbk_program shade;
    glbk_program record;
    glbk_buffer  frame;
    glbk_buffer  object;
    uint32_t     width;
    uint32_t     height;
    uint32_t     bands;
    uint32_t     self_attribute;
    int          compute;               /* not 0: pixels are shaded by a compute shader */
    int32_t      position_attribute;    /* the attribute that record was compiled for */
    float        world_to_clip[16];     /* the matrix of glbk_sfield_self_begin */
};

struct glbk_sfield_builder {            /* draws one object from all sides; read only; zeroed = none */
    uint32_t      batch;                /* the most eyes of which cubes are kept at once */
    uint32_t      side;                 /* private, like all that follows: texels a side of a face */
    uint32_t      bands;                /* of the coefficients; 0 = texels are wanted */
    uint32_t      groups;               /* groups of four coefficients */
    uint32_t      height;               /* pixels of the atlas */
    int           source;               /* as in the desc, like the next two */
    glbk_sfield_draw_fn draw_fn;
    void         *user;
    float         center[3];            /* of the sphere round your mesh */
    float         radius;               /* of that sphere */
    uint32_t      vertex_array;
    uint32_t      index_count;
    glbk_buffer   vertices;
    glbk_buffer   indices;
    glbk_buffer   block;
    glbk_texture  seen;                 /* the atlas */
    glbk_texture  depth;
    glbk_texture  cube;
    glbk_texture  coefs;
    glbk_texture  basis;                /* integrals of the basis over texels */
    glbk_target   seen_target;
    glbk_target   cube_target;
    glbk_target   coef_target;
    glbk_program  see;
    glbk_program  sum;
    glbk_program  project;
    struct glbk_sfield_views *views;    /* the block's values */
    uint32_t     *words;                /* texels that were read back */
    int           compute;
};
