/* ---- self-visibility: what a point's own object leaves open ---- */

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

/* For the library's tools and tests: returns the GLSL of this header, which is for its own programs alone. */
GLBK__DEF const glbk_part *glbk__wavelets(void);

/* ---- objects: read only ---- */

struct glbk_sfield_haar {               /* the light of a picture; read only; zeroed = none */
    glbk_texture light;                 /* GLBK_FORMAT_COLOR: rgb times albedo is radiance; a is the open
                                           share of the cosine-weighted sphere */
    glbk_texture gloss;                 /* Phong: rgb times the specular color is radiance; metal-rough: rgb
                                           is radiance, and light's rgb has its factor 1 - F. Made if
                                           desc.gloss is set */
    glbk_target  target;                /* of light and gloss, for glbk_target_read */
    glbk_texture self;                  /* private, like all that follows but width, height and cube_side */
    glbk_texture list[3];               /* kinds, and weights of corners and of shells */
    glbk_texture met[2];
    glbk_texture cubes;
    glbk_texture left[2][4];            /* T, in two parts, and sums of light and gloss */
    glbk_target  list_target[2];
    glbk_target  cubes_target;
    glbk_target  left_target[2];
    glbk_program find;
    glbk_program write;
    glbk_program multiply;
    glbk_program sum;
    glbk_program shade;                 /* by compute, in place of all these */
    glbk_buffer  kept;                  /* T and kernels of a batch */
    glbk_buffer  block;
    uint32_t     width;
    uint32_t     height;
    uint32_t     cube_side;
    uint32_t     batch;                 /* points */
    uint32_t     columns;               /* cubes in a row of their texture */
    int          has_self;
    int          has_gloss;
    int          compute;               /* not 0: pixels are shaded by a compute shader */
    uint64_t     self_of;               /* which scene's places self has; 0 = nothing was said */
};
