/* ---- what the GLSL declares; see "bindings" in gl_programs.h ---- */

/* Programs that shade read the two tables, and self-visibility of a picture. */
#define GLBK_SFIELD_SCENE_TEXTURES(X)                                                       \
    X(usampler2DArray, glbk_sfield_table, 0)        /* terms of the product, fields */      \
    X(usampler2DArray, glbk_sfield_moving, 7)       /* sky, entities, rotations */          \
    X(usampler2DArray, glbk_sfield_self, 3)         /* self-visibility of a picture */

/* Programs that build read samples of tiles, texels of cubes, and integrals of the basis over texels. */
#define GLBK_SFIELD_BUILD_TEXTURES(X)                                                       \
    X(usampler2D, glbk_sfield_seen, 4)              /* samples of tiles */                  \
    X(usampler2D, glbk_sfield_cube, 5)              /* texels of cubes */                   \
    X(usampler2DArray, glbk_sfield_basis, 6)        /* integrals over texels */

#define GLBK_SFIELD_TEXTURES(X)                                                             \
    GLBK_SFIELD_SCENE_TEXTURES(X)                                                           \
    GLBK_SFIELD_BUILD_TEXTURES(X)

/* This block says what the tables hold. */
#define GLBK_SFIELD_CONTENTS_MEMBERS(X)                                                     \
    X(uint, entity_texel, 1)        /* where entities begin in glbk_sfield_moving */        \
    X(uint, entity_count, 1)        /* entities in use */                                   \
    X(uint, light_count, 1)         /* entities that shine */                               \
    X(uint, wants_sky, 1)           /* not 0: the sky, or the open share, is wanted */      \
    X(uint, term_texel, 1)          /* where terms begin in glbk_sfield_table */            \
    X(uint, term_count, 1)          /* texels of terms, two terms each */                   \
    X(uint, sky_texel, 1)           /* where the sky begins in glbk_sfield_moving */        \
    X(uint, brdf_texel, 1)          /* where kernels of BRDFs begin in glbk_sfield_table */

#define GLBK_SFIELD_FRAME_MEMBERS(X) X(vec4, eye, 1)        /* world; w is not used */

/* This block has an object whose self-visibility is drawn. */
#define GLBK_SFIELD_OBJECT_MEMBERS(X)                                                       \
    X(mat4, transform, 1)           /* object to world */                                   \
    X(mat4, clip, 1)                /* world to clip space */

#ifndef GLBK_SFIELD_WITHOUT_BUILD
/* This block has the tiles of an atlas, each of which is a face of an eye's cube. */
#define GLBK_SFIELD_VIEWS_MEMBERS(X)                                                        \
    X(vec4, sphere, 1)              /* of the field: centre, radius */                      \
    X(uint, first_tile, 1)          /* the first tile of the column that is drawn */        \
    X(uint, rows, 1)                /* tiles of a column */                                 \
    X(uint, width, 1)               /* samples a side of a tile */                          \
    X(uint, side, 1)                /* texels a side of a face */                           \
    X(uint, batch, 1)               /* eyes */                                              \
    X(uint, groups, 1)              /* of four coefficients */                              \
    X(uint, unused0, 1)                                                                     \
    X(uint, unused1, 1)                                                                     \
    GLBK_SFIELD_TILE_MEMBERS(X)

#define GLBK_SFIELD_TILE_MEMBERS(X)                                                         \
    X(vec4, eyes, 256)              /* places in radii about the centre; 1 / greatest depth */ \
    X(uvec4, places, 256)           /* face, number of the eye; column, row of the atlas */

#define GLBK_SFIELD_BUILD_BLOCKS(X) X(glbk_sfield_views, 3, GLBK_SFIELD_VIEWS_MEMBERS)
#else
#define GLBK_SFIELD_BUILD_BLOCKS(X)
#endif

#define GLBK_SFIELD_BLOCKS(X)                                                               \
    X(glbk_sfield_contents, 0, GLBK_SFIELD_CONTENTS_MEMBERS)                                \
    X(glbk_sfield_frame, 1, GLBK_SFIELD_FRAME_MEMBERS)                                      \
    X(glbk_sfield_object, 2, GLBK_SFIELD_OBJECT_MEMBERS)                                    \
    GLBK_SFIELD_BUILD_BLOCKS(X)

#define GLBK_SFIELD_STORAGE(X)

/* Compute shaders write a picture's light, gloss and grazing, and cubes and coefficients of a builder. */
#define GLBK_SFIELD_IMAGES(X)                                                               \
    X(writeonly, rgba32f, image2D, glbk_sfield_light_image, 0)                              \
    X(writeonly, rgba32f, image2D, glbk_sfield_gloss_image, 1)                              \
    X(writeonly, rgba32ui, uimage2D, glbk_sfield_cube_image, 2)                             \
    X(writeonly, rgba32ui, uimage2D, glbk_sfield_coefs_image, 3)                            \
    X(writeonly, rgba32f, image2D, glbk_sfield_grazing_image, 4)

GLBK__PART(SFIELD)
