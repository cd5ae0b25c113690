/* ---- csm: what its GLSL declares; see "bindings" in gl_programs.h ---- */

/* Tables of blocks, lights and instances, and questions. */
#define GLBK_CSM_SCENE_TEXTURES(X)              \
    X(usampler2DArray, glbk_csm_blocks, 0)      \
    X(usampler2DArray, glbk_csm_lights, 1)      \
    X(usampler2DArray, glbk_csm_instances, 7)   \
    X(usampler2DArray, glbk_csm_questions, 5)

/* Pictures: the sum of the frames, and two textures of the G-buffer, whose own slots are 8 to 11. */
#define GLBK_CSM_PICTURE_TEXTURES(X)            \
    X(usampler2D, glbk_csm_place, 2)            \
    X(usampler2D, glbk_csm_normal, 3)           \
    X(glbk_color_sampler, glbk_csm_sum, 6)

/* Building: depth layers of a batch of views, and the open segment of each pixel. */
#define GLBK_CSM_BUILD_TEXTURES(X)              \
    X(usampler2D, glbk_csm_layer0, 2)           \
    X(usampler2D, glbk_csm_layer1, 3)           \
    X(usampler2D, glbk_csm_layer2, 4)           \
    X(usampler2D, glbk_csm_opened, 5)

#define GLBK_CSM_TEXTURES(X)                    \
    GLBK_CSM_SCENE_TEXTURES(X)                  \
    GLBK_CSM_PICTURE_TEXTURES(X)                \
    GLBK_CSM_BUILD_TEXTURES(X)

/* The instances of a scene. */
#define GLBK_CSM_SCENE_MEMBERS(X)                                                               \
    X(uint, count, 1)                                                                           \
    X(uint, in_block, 1)            /* 1: they stand in this block, 0: in their table */        \
    X(uint, pad0, 1) X(uint, pad1, 1)                                                           \
    X(uvec4, instances, 192)        /* 12 for each of 16: its record, texels 1 to 7 of its block */

/* This block says what one pass shades: samples of one light. */
#define GLBK_CSM_LIGHT_MEMBERS(X)                                                               \
    X(uint, light_texel, 1)         /* where the light begins in its table */                   \
    X(uint, pattern_texel, 1)       /* where the patterns begin in that table */                \
    X(uint, sample_count, 1)        /* S, of this light in this frame */                        \
    X(uint, sampling, 1)            /* lsamp_sampling */                                        \
    X(uint, seed, 1)                                                                            \
    X(uint, roulette_seed, 1)                                                                   \
    X(uint, frame, 1)                                                                           \
    X(uint, first, 1)               /* the pass takes samples first .. end - 1 of each pixel; */ \
    X(uint, end, 1)                 /* of an asker there are questions 0 .. end - 1 */

/* A pass of the renderer, a resolve, or questions. */
#define GLBK_CSM_FRAME_MEMBERS(X)                                                               \
    GLBK_CSM_LIGHT_MEMBERS(X)                                                                   \
    X(uint, plane_count, 1)                                                                     \
    X(uint, width, 1) X(uint, height, 1)                                                        \
    X(float, bias, 1)               /* pixels of a map */                                       \
    X(float, offset, 1)             /* pixels of a map that receivers of local lights move */   \
    X(uint, adds, 1)                /* 0: the sum begins with this pass */                      \
    X(float, frame_share, 1)        /* resolve: 1 / frames in the sum; 0: there are none */     \
    X(vec4, eye, 1)                 /* world; w is not used */                                  \
    X(vec4, own, 1)                 /* numbers for GLSL of the user's */                        \
    X(vec4, planes, 8)              /* unit normal, distance from the origin */

#ifndef GLBK_CSM_WITHOUT_BUILD
/* A batch of views that are drawn and compressed. */
#define GLBK_CSM_PEEL_MEMBERS(X)                                                                \
    X(mat4, view, 1)                /* object space to pixels of a tile, and depth or w */      \
    X(float, clip_per_pixel, 1)     /* 2 / side */                                              \
    X(float, depth_scale, 1)        /* of w, in perspective views; 0: z is the depth */         \
    X(float, open_thickness, 1)     /* in 16-bit depths; of the depth, in perspective views */  \
    X(uint, depth_top, 1)           /* the greatest value of the grid of depths */              \
    X(uint, side, 1) X(uint, tiles_across, 1) X(uint, view_count, 1)                            \
    GLBK_CSM_LAYER_MEMBERS(X)

#define GLBK_CSM_LAYER_MEMBERS(X)                                                               \
    X(uint, far_layer, 1)           /* not 0: COHSM_LAYERS_Z1Z3_FAR, or _SPHERE */              \
    X(uint, positional, 1)          /* not 0: perspective views */                              \
    X(uint, self_only, 1)           /* as in cohsm_desc */                                      \
    X(uint, sphere, 1)              /* not 0: COHSM_LAYERS_Z1Z3_SPHERE */                       \
    X(uint, pad0, 1)                                                                            \
    X(vec4, eyes, 64)               /* of each view: place along the axes of its face, in radii about the \
                                       sphere; a radius in depths */

#define GLBK_CSM_BUILD_BLOCKS(X) X(glbk_csm_peel, 3, GLBK_CSM_PEEL_MEMBERS)
#else
#define GLBK_CSM_BUILD_BLOCKS(X)
#endif

#define GLBK_CSM_BLOCKS(X)                              \
    X(glbk_csm_scene, 0, GLBK_CSM_SCENE_MEMBERS)        \
    X(glbk_csm_frame, 1, GLBK_CSM_FRAME_MEMBERS)        \
    GLBK_CSM_BUILD_BLOCKS(X)

/* Questions, two uvec4 each, and their answers; open segments and records of a builder, four uvec4 a
   pixel. */
#define GLBK_CSM_STORAGE(X)                             \
    X(readonly, uvec4, glbk_csm_asked, 1)               \
    X(writeonly, float, glbk_csm_answers, 2)            \
    X(restrict, uvec4, glbk_csm_records, 3)

/* The sum of the frames, changed in place. */
#define GLBK_CSM_IMAGES(X) X(restrict, rgba32f, image2D, glbk_csm_total, 0)

GLBK__PART(CSM)
