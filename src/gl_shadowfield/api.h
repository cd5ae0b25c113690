/* ---- the light of a picture ---- */

GLBK_DEF glbk_result glbk_sfield_renderer_resize(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                                 uint32_t width, uint32_t height);
/* Gives the renderer another size, without what it had drawn; self-visibility is forgotten, too. Its programs
   stay, whereas a new renderer would compile them anew; so call it when a window has changed its size, with
   glbk_gbuffer_resize.
   Errors   GLBK_ERR_ARGUMENT: the renderer is NULL or was not created. GLBK_ERR_DESC, GLBK_ERR_LIMIT: as for
            glbk_sfield_renderer_create. After these it is as it was, after those of textures and targets
            it is freed and zeroed */

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
   goes after lib/sfield_access.glsl and lib/sfield_field.glsl and before lib/sfield_shade.glsl. The call
   needs no context and has no log.
   out      receives the text, cut to out_bytes and ended by 0; it may be NULL with out_bytes 0
   Returns the bytes needed with the 0, or 0 without an algebra and for more than 4 bands, which do not gain
   by it. */

/* ---- self-visibility: what a point's own object leaves open ----

   Fields say what other objects hide of a point; what its own object hides is recorded for the vertices of
   its mesh, by sfield_build_self, as visibility x cosine. A renderer with desc.self has room for
   self-visibility, and keeps it from frame to frame until it is given anew; pixels without it take the
   cosine. Self-visibility is in the space of the entity that the G-buffer names there, and turns with the
   entity. After the draws into the G-buffer come these calls:

       glbk_sfield_self_begin(gl, &renderer, &gbuffer);
       glbk_sfield_self_object(gl, &renderer, surface.transform);   // for each object, and your draw */

GLBK_DEF glbk_result glbk_sfield_self_begin(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                            const glbk_gbuffer *gbuffer);
/* Forgets self-visibility at all pixels and begins a pass that draws it anew, at the places that were drawn
   into the G-buffer, whose depth and matrix the pass uses. The first call compiles a program.
   Errors   GLBK_ERR_ARGUMENT: an object is NULL or was not created. GLBK_ERR_ORDER: the G-buffer was not
            drawn. GLBK_ERR_LIMIT: more than 4 bands. GLBK_ERR_MISMATCH: the renderer was made without
            desc.self, the G-buffer has another size, or its position attribute is one of the four from
            desc.self_attribute on. Those of glbk_program_compile */

GLBK_DEF glbk_result glbk_sfield_self_object(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                             const float transform[16]);
/* Says which object the next draws are of: bind its vertex array and draw. The array has the position in the
   attribute of the G-buffer, and four coefficients each in the attributes from desc.self_attribute on.
   transform   that of its glbk_surface, so that depths are equal; zeros = identity
   Errors      GLBK_ERR_ARGUMENT: a pointer is NULL, or renderer was not created. GLBK_ERR_MISMATCH: the
               renderer has no desc.self. GLBK_ERR_ORDER: glbk_sfield_self_begin has not been called */

GLBK_DEF glbk_result glbk_sfield_self_upload(glbk_context *ctx, glbk_sfield_renderer *renderer, uint32_t row,
                                             uint32_t row_count, const float *const *self);
/* Writes self-visibility of whole rows of pixels from memory, for a G-buffer that was uploaded. Coefficients
   are kept with 16 bits, off by 5e-5.
   self     renderer->width x row_count pointers: bands^2 coefficients from sfield_self, mixed as you like, or
            NULL where nothing is known
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, renderer was not created, or rows reach beyond height.
            GLBK_ERR_MISMATCH: the renderer has no desc.self. GLBK_ERR_ALLOC */

/* ---- objects: read only ---- */

typedef struct glbk_sfield_field {      /* a field in the table; read only */
    const sfield_field *field;
    uint32_t start;                     /* its first texel, for sfield_locate() and sfield_fetch() */
    int      source;                    /* 0: an occlusion field; 1: a source; 2: self-visibility */
    float    center[3];                 /* in the field's own space */
    float    radius;
    float    inscribed;                 /* radius of the inscribed sphere */
    float    outer;                     /* the outermost shell, in radii */
} glbk_sfield_field;

struct glbk_sfield_scene {              /* fields and where they stand; read only; zeroed = none */
    glbk_texture table;                 /* terms and fields */
    glbk_texture moving;                /* the sky, entities, rotations */
    glbk_buffer  contents;              /* the uniform block */
    uint32_t     bands;                 /* of harmonics */
    uint32_t     cube_side;             /* of wavelets; 0: the fields are of harmonics */
    uint32_t     entity_capacity;
    uint32_t     entity_count;
    uint32_t     light_count;           /* entities that shine */
    glbk_sfield_field *fields;          /* in the order of their pointers */
    size_t       field_count;
    uint32_t     terms;                 /* private, like all that follows: texels of the terms */
    uint32_t     texels;                /* texels of the table */
    uint32_t     entities_at;           /* the texel of moving at which entities begin */
    int          sky;                   /* not 0: there is a sky */
    int          has_brdf;              /* not 0: BRDFs come after the terms */
    int          logarithms;            /* not 0: occlusion fields hold logarithms */
    int          lists;                 /* of wavelets: not 0: fields are lists, for compute shaders */
    float        reach;
    uint64_t     key;                   /* of wavelets: which fields begin where */
    const sfield_algebra *algebra;
};

struct glbk_sfield_renderer {           /* the light of a picture; read only; zeroed = none */
    glbk_texture light;                 /* GLBK_FORMAT_COLOR: rgb times albedo is radiance; a is the open
                                           share of the cosine-weighted sphere */
    glbk_texture gloss;                 /* Phong: rgb times the specular colour is radiance; metal-rough: rgb
                                           is radiance, and light's rgb has its factor 1 - F. Made if
                                           desc.gloss or desc.materials is set */
    glbk_texture grazing;               /* metal-rough: the part of gloss that F0 does not color, as
                                           sfield_points.grazing; none without desc.grazing */
    glbk_texture self;                  /* self-visibility; none without desc.self */
    glbk_target  target;                /* of light, gloss and grazing */
    glbk_target  self_target;           /* private, like all that follows but width, height and compute */
    glbk_program shade;
    glbk_program record;
    glbk_buffer  frame;
    glbk_buffer  object;
    uint32_t     width;
    uint32_t     height;
    uint32_t     bands;
    uint32_t     self_attribute;
    int          materials;
    int          logarithms;
    int          compute;               /* not 0: pixels are shaded by a compute shader */
    int32_t      record_position;       /* the attribute that record was compiled for */
    const char  *record_vertex;         /* the function of yours that it was compiled with */
    float        world_to_clip[16];     /* the matrix of glbk_sfield_self_begin */
};
