/* ---- what the GLSL declares; see "bindings" in gl_programs.h ---- */

/* Programs read what a batch of points wrote before: lists, cubes, T and sums. They stand beside the tables
   and self-visibility of gl_shadowfield.h. */
#define GLBK_HAAR_TEXTURES(X)                                                               \
    X(usampler2D, glbk_haar_what, 4)                /* kind, first sample, entity, field */ \
    X(usampler2D, glbk_haar_corner, 5)              /* weights of four samples */           \
    X(usampler2D, glbk_haar_weight, 6)              /* of two shells and frames */          \
    X(usampler2D, glbk_haar_met, 1)                 /* distances and ids of a round */      \
    X(usampler2D, glbk_haar_cubes, 2)               /* texels of lists' cubes */            \
    X(usampler2D, glbk_haar_lower, 12)              /* T after the round before */          \
    X(usampler2D, glbk_haar_upper, 13)                                                      \
    X(usampler2D, glbk_haar_sums, 14)               /* light of the rounds before */        \
    X(usampler2D, glbk_haar_shine, 1)               /* their gloss; no program reads met, too */

/* This block says which points a batch has, and how textures hold them. */
#define GLBK_HAAR_BATCH_MEMBERS(X)                                                          \
    X(uint, left, 1) X(uint, bottom, 1)     /* a rectangle of pixels */                     \
    X(uint, width, 1)                                                                       \
    X(uint, count, 1)                       /* points */                                    \
    X(uint, slots, 1)                       /* places of a list */                          \
    X(uint, round, 1)                       /* lists of so many places before this one */   \
    X(uint, last, 1)                        /* not 0: adds the sky and the open share */    \
    X(uint, own, 1)                         /* not 0: there is self-visibility */           \
    X(uint, side, 1)                        /* texels a side of a cube's face */            \
    X(uint, columns, 1)                     /* cubes of a row */                            \
    X(uint, unused0, 1) X(uint, unused1, 1)                                                 \
    X(vec4, eye, 1)                         /* world; w is not used */

#define GLBK_HAAR_BLOCKS(X) X(glbk_haar_batch, 4, GLBK_HAAR_BATCH_MEMBERS)
/* The compute shader keeps T there if shared memory has no room for it, and kernels of BRDFs. */
#define GLBK_HAAR_STORAGE(X) X(restrict, float, glbk_haar_left, 0)

#define GLBK_HAAR_IMAGES(X)

GLBK__PART(HAAR)
