/* ---- what the GLSL of this header declares; see "bindings" in gl_programs.h ---- */

#define GLBK_ENVSH_TEXTURES(X)                                                                      \
    X(sampler2DArray, glbk_envsh_depth, 0)      /* the atlas, of depths */                          \
    X(usampler2DArray, glbk_envsh_depth4, 1)    /* with rgba: the atlas, of four maps' bits */      \
    X(usampler2DArray, glbk_envsh_cells, 2)     /* least and greatest depth of cells, as bits */    \
    X(usampler2DArray, glbk_envsh_views, 3)     /* the table of lights */                           \
    X(glbk_color_sampler, glbk_envsh_sum, 4)    /* irradiance so far */

#define GLBK_ENVSH_SCENE_MEMBERS(X)                                                                 \
    X(uint, map_side, 1)            /* texels a side of a tile */                                   \
    X(uint, guard, 1)               /* texels at each side of a tile that stay empty */             \
    X(uint, cells_side, 1)          /* cells a side of a tile, on the finest level */               \
    X(uint, level_count, 1)         /* levels of cells */                                           \
    X(uint, light_count, 1)         /* lights whose maps were rendered last */                      \
    X(float, clip_per_inside, 1)    /* 2 / texels a side of a tile without its guard */             \
    X(float, clip_per_texel_x, 1)   /* 2 / texels of a page along x */                              \
    X(float, clip_per_texel_y, 1)   /* 2 / texels of a page along y */

#define GLBK_ENVSH_QUERY_MEMBERS(X)                                                                 \
    X(float, radius, 1)             /* of envsh_query with its default, like the next four */       \
    X(float, bias, 1)                                                                               \
    X(float, extent_scale, 1)                                                                       \
    X(uint, taps, 1)                                                                                \
    X(uint, seed, 1)                                                                                \
    X(uint, first_light, 1)         /* the first light of a pass */                                 \
    X(uint, end_light, 1)           /* the light after its last */                                  \
    X(uint, adds, 1)                /* not 0: their light is added to the sum; 0: it begins here */ \
    X(vec4, disc, 32)               /* the taps on the unit disc, two in each */

#define GLBK_ENVSH_OBJECT_MEMBERS(X)                                                                \
    X(mat4, transform, 1)           /* of a caster: object to world */                              \
    X(uint, first_light, 1)         /* the light of instance 0 */                                   \
    X(uint, light_step, 1)          /* from the light of an instance to that of the next */         \
    X(uint, level, 1)               /* the level of cells that are made */                          \
    X(uint, layer, 1)               /* the layer of cells that are made */                          \
    X(uint, lit, 1)                 /* of a resolve: not 0 if the sum holds light */                \
    X(uint, unused0, 1)                                                                             \
    X(uint, unused1, 1)                                                                             \
    X(uint, unused2, 1)

#define GLBK_ENVSH_BLOCKS(X)                                \
    X(glbk_envsh_scene, 0, GLBK_ENVSH_SCENE_MEMBERS)        \
    X(glbk_envsh_query, 1, GLBK_ENVSH_QUERY_MEMBERS)        \
    X(glbk_envsh_object, 2, GLBK_ENVSH_OBJECT_MEMBERS)

#define GLBK_ENVSH_STORAGE(X)
#define GLBK_ENVSH_IMAGES(X)    X(restrict, rgba32f, image2D, glbk_envsh_total, 0)   /* the sum, by compute */

GLBK__PART(ENVSH)
