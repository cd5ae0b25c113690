/* ---- gbuffer: what its GLSL declares; see "bindings" in gl_programs.h ---- */

/* The four textures of the G-buffer, which are read; no technique uses these slots for anything else. */
#define GLBK_GBUFFER_READ_TEXTURES(X)           \
    X(usampler2D, glbk_gbuffer_place, 8)        \
    X(usampler2D, glbk_gbuffer_normal, 9)       \
    X(usampler2D, glbk_gbuffer_color, 10)       \
    X(usampler2D, glbk_gbuffer_gloss, 11)

/* Maps of objects that are drawn; an import has the first two. */
#define GLBK_GBUFFER_MAP_TEXTURES(X)            \
    X(sampler2D, glbk_gbuffer_color_map, 0)     \
    X(sampler2D, glbk_gbuffer_gloss_map, 1)     \
    X(sampler2D, glbk_gbuffer_normal_map, 2)

/* Textures that are imported besides. */
#define GLBK_GBUFFER_IMPORT_TEXTURES(X)         \
    X(sampler2D, glbk_gbuffer_place_in, 2)      \
    X(sampler2D, glbk_gbuffer_depth_in, 3)      \
    X(sampler2D, glbk_gbuffer_normal_in, 4)     \
    X(sampler2D, glbk_gbuffer_flat_in, 5)       \
    X(sampler2D, glbk_gbuffer_open_in, 6)       \
    X(usampler2D, glbk_gbuffer_entity_in, 7)

#define GLBK_GBUFFER_TEXTURES(X)                \
    GLBK_GBUFFER_READ_TEXTURES(X)               \
    GLBK_GBUFFER_MAP_TEXTURES(X)                \
    GLBK_GBUFFER_IMPORT_TEXTURES(X)

/* The material of an object, or of all that is imported. */
#define GLBK_GBUFFER_MATERIAL_MEMBERS(X)                                                    \
    X(vec4, diffuse, 1)             /* rgb: albedo or base colour; a: opacity, of objects */ \
    X(vec4, gloss, 1)               /* Phong: specular colour, exponent; metal-rough: metallic, roughness */ \
    X(uint, kind, 1)                /* lsamp_material_kind, never the default */            \
    X(uint, entity, 1)                                                                      \
    X(uint, plane, 1)                                                                       \
    X(float, occlusion, 1)                                                                  \
    X(uint, first_lobe, 1)                                                                  \
    X(uint, lobe_count, 1)

/* One object that is drawn. */
#define GLBK_GBUFFER_DRAWN_MEMBERS(X)                                                       \
    X(mat4, transform, 1)           /* object to world */                                   \
    X(mat4, clip, 1)                /* world to clip space */                               \
    X(vec4, eye, 1)                 /* world; w is not used */                              \
    GLBK_GBUFFER_MATERIAL_MEMBERS(X)                                                        \
    X(uint, maps, 1)                /* bits: 1 a colour map, 2 a gloss map, 4 a normal map */ \
    X(float, alpha_cutoff, 1)

/* One import. */
#define GLBK_GBUFFER_IMPORTED_MEMBERS(X)                                                    \
    X(mat4, from_clip, 1)           /* clip space to world */                               \
    X(mat4, to_clip, 1)             /* world to clip space */                               \
    X(mat4, to_world, 1)            /* the space of positions and normals to world */       \
    X(vec4, eye, 1)                 /* world; w is not used */                              \
    GLBK_GBUFFER_MATERIAL_MEMBERS(X)                                                        \
    X(uint, given, 1)               /* bits of gbuffer_import.frag: the textures that there are */ \
    X(uint, normal_packing, 1)      /* glbk_normal_packing */                               \
    X(uint, width, 1) X(uint, height, 1)                                                    \
    X(float, depth_scale, 1)        /* clip z of a depth d is depth_scale d + depth_offset */ \
    X(float, depth_offset, 1)

/* This block says which pixels a resolve draws to, and has the fields of a glbk_picture. */
#define GLBK_SHOWN_MEMBERS(X)                                                                           \
    X(mat4, to_clip, 1)             /* world to clip space, with has_depth */                           \
    X(uint, left, 1)                /* pixels of the target, an int by its bits */                      \
    X(uint, bottom, 1)                                                                                  \
    X(uint, keep_empty, 1)                                                                              \
    X(uint, has_depth, 1)

#define GLBK_GBUFFER_BLOCKS(X)                                  \
    X(glbk_gbuffer_drawn, 0, GLBK_GBUFFER_DRAWN_MEMBERS)        \
    X(glbk_gbuffer_imported, 0, GLBK_GBUFFER_IMPORTED_MEMBERS)  \
    X(glbk_shown, 7, GLBK_SHOWN_MEMBERS)

#define GLBK_GBUFFER_STORAGE(X)
#define GLBK_GBUFFER_IMAGES(X)

GLBK__PART(GBUFFER)
