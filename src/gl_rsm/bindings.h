/* ---- what the GLSL declares; see "bindings" in gl_programs.h ---- */

#define GLBK_RSM_MAP_TEXTURES(X)                                                                        \
    X(usampler2DArray, glbk_rsm_texels, 0)      /* layers 3 face + 0 place, 1 normal, 2 flux */         \
    X(usampler2DArray, glbk_rsm_sums, 1)        /* running sums of flux along rows */                   \
    X(usampler2DArray, glbk_rsm_rows, 2)        /* running sums of whole rows */                        \
    X(usampler2DArray, glbk_rsm_lights, 3)      /* the list of pixel lights */                          \
    X(sampler2D, glbk_rsm_pattern, 4)                                                                   \
    X(sampler2D, glbk_rsm_noise, 5)                                                                     \
    X(sampler2D, glbk_rsm_materials, 6)

#define GLBK_RSM_PICTURES(X)                                                                            \
    X(glbk_color_sampler, glbk_rsm_sum, 7)      /* light so far; 8 to 11 are the G-buffer's */          \
    X(glbk_color_sampler, glbk_rsm_states, 12)  /* the picture while it is interpolated */              \
    X(glbk_color_sampler, glbk_rsm_coarse, 13)  /* a grid of samples */                                 \
    X(glbk_color_sampler, glbk_rsm_history, 14)                                                         \
    X(usampler2DArray, glbk_rsm_before, 15)     /* place and normal of the last frame */                \
    X(sampler2D, glbk_rsm_motion, 1)            /* in programs that read no map */                      \
    X(sampler2D, glbk_rsm_albedo_map, 2)        /* in programs that read no map */

/* What an import reads, in programs that read nothing else: 2D textures, layers of arrays, or cubes. */
#define GLBK_RSM_IMPORT_TEXTURES(X)                                                                     \
    X(sampler2D, glbk_rsm_depth_in, 3)                                                                  \
    X(sampler2D, glbk_rsm_place_in, 4)                                                                  \
    X(sampler2D, glbk_rsm_normal_in, 5)                                                                 \
    X(sampler2D, glbk_rsm_color_in, 6)                                                                  \
    X(usampler2D, glbk_rsm_material_in, 7)                                                              \
    X(sampler2DArray, glbk_rsm_depth_array, 3)                                                          \
    X(sampler2DArray, glbk_rsm_place_array, 4)                                                          \
    X(sampler2DArray, glbk_rsm_normal_array, 5)                                                         \
    X(sampler2DArray, glbk_rsm_color_array, 6)                                                          \
    X(usampler2DArray, glbk_rsm_material_array, 7)                                                      \
    X(samplerCube, glbk_rsm_depth_cube, 3)                                                              \
    X(samplerCube, glbk_rsm_place_cube, 4)                                                              \
    X(samplerCube, glbk_rsm_normal_cube, 5)                                                             \
    X(samplerCube, glbk_rsm_color_cube, 6)                                                              \
    X(highp usamplerCube, glbk_rsm_material_cube, 7)    /* ES has no precision for its kind */

#define GLBK_RSM_TEXTURES(X) GLBK_RSM_MAP_TEXTURES(X) GLBK_RSM_PICTURES(X) GLBK_RSM_IMPORT_TEXTURES(X)

#define GLBK_RSM_LIGHT_AXES_MEMBERS(X)                                                                  \
    X(vec4, position, 1)            /* w is 1; w of the next four is 0 */                               \
    X(vec4, right, 1)               /* axis x of face 0 */                                              \
    X(vec4, up, 1)                  /* axis y of face 0 */                                              \
    X(vec4, axis, 1)                /* axis z of face 0, along which light travels */                   \
    X(vec4, value, 1)               /* as in rsm_light */

#define GLBK_RSM_LIGHT_SHAPE_MEMBERS(X)                                                                 \
    X(float, extent, 1)             /* half a side of the map (sun), or the tangent */          \
    X(float, cos_half, 1)           /* cosine of half the cone */                                       \
    X(uint, side, 1)                /* texels a side of a face */                                       \
    X(uint, face_count, 1)                                                                              \
    X(uint, kind, 1)                /* rsm_light_kind */                                                \
    X(uint, unused0, 1)                                                                                 \
    X(uint, unused1, 1)                                                                                 \
    X(uint, unused2, 1)

#define GLBK_RSM_LIGHT_MEMBERS(X) GLBK_RSM_LIGHT_AXES_MEMBERS(X) GLBK_RSM_LIGHT_SHAPE_MEMBERS(X)

#define GLBK_RSM_LIST_MEMBERS(X)                                                                        \
    X(uint, interleave, 1)          /* pixels a side that share the samples */                          \
    X(uint, point_count, 1)         /* points about the receiver */                                     \
    X(uint, noise_side, 1)          /* texels a side of the noise; 0 = none */                          \
    X(uint, material_count, 1)                                                                          \
    X(uint, first_light, 1)         /* the first light of the list */                                   \
    X(uint, end_light, 1)           /* 1 + the last light of the list */                                \
    X(uint, set_room, 1)            /* lights of a set that the list has room for */                    \
    X(uint, adds, 1)                /* not 0: light is added to the sum; 0: the sum begins here */

#define GLBK_RSM_PICK_MEMBERS(X)                                                                        \
    X(uint, seed, 1)                /* of random numbers */                                             \
    X(uint, light_count, 1)         /* lights that are picked from a map */                             \
    X(uint, first_run, 1)           /* number of the first light that a pass picks for each set */      \
    X(uint, taps, 1)                /* texels a side of the filter of direct light */                   \
    X(uint, width, 1)               /* of the picture, in pixels */                                     \
    X(uint, height, 1)              /* of the picture, in pixels */                                     \
    X(uint, face, 1)                /* of running sums: the face */                                     \
    X(uint, stride, 1)              /* of running sums: texels between the values of a step */

#define GLBK_RSM_GRID_MEMBERS(X)                                                                        \
    X(uint, mode, 1)                /* what is lit: 0 pixels, 1 nodes of a grid, 2 pending pixels */    \
    X(uint, step, 1)                /* pixels from node to node, or from tap to tap of a filter */      \
    X(uint, coarse_step, 1)         /* of the grid before; 0 = there is none */                         \
    X(uint, next_step, 1)           /* of the grid after this; 0 = there is none */                     \
    X(uint, fine_step, 1)           /* compute: of the finest grid */                                   \
    X(uint, list_read, 1)           /* compute: the list that is read */                                \
    X(uint, list_pending, 1)        /* compute: the list of pixels that stay pending */                 \
    X(uint, list_wanted, 1)         /* compute: the list of nodes that are wanted */

#define GLBK_RSM_SHOW_MEMBERS(X)                                                                        \
    X(uint, motion, 1)              /* what finds history: 0 nothing, 1 a matrix, 2 a texture */        \
    X(uint, rows_top_first, 1)      /* not 0: the top row of the picture is row 0 */                    \
    X(uint, shows_direct, 1)        /* not 0: a resolve shows direct light */                           \
    X(uint, shows_bounced, 1)       /* not 0: a resolve shows bounced light */

#define GLBK_RSM_SAMPLING_MEMBERS(X)                                                                    \
    X(float, r_max, 1)              /* as in rsm_gather_desc */                                         \
    X(float, offset, 1)             /* as in rsm_gather_desc */                                         \
    X(float, clamp_at, 1)           /* rsm_gather_desc.clamp */                                         \
    X(float, near_limit, 1)         /* as in rsm_gather_desc */                                         \
    X(float, near_field, 1)         /* as in rsm_gather_desc */                                         \
    X(float, set_count, 1)          /* sets of pixels: interleave^2 */                                  \
    X(float, mixed, 1)              /* scale of RSM_PATTERN_MIXED; 0 = another pattern */               \
    X(float, picked, 1)             /* lights that RSM_PATTERN_MIXED picks by flux */

#define GLBK_RSM_TEST_MEMBERS(X)                                                                        \
    X(float, bias, 1)               /* as in rsm_direct_desc */                                         \
    X(float, slope_bias, 1)         /* as in rsm_direct_desc */                                         \
    X(float, reach, 1)              /* as in rsm_interpolation */                                       \
    X(float, contrast, 1)           /* as in rsm_interpolation */                                       \
    X(float, normal_cosine, 1)      /* as in rsm_interpolation or gifilt_frame */                       \
    X(float, plane_slope, 1)        /* as in rsm_interpolation or gifilt_frame */                       \
    X(float, most_distance, 1)      /* rsm_interpolation.distance */                                    \
    X(float, history, 1)            /* as in gifilt_frame */

#define GLBK_RSM_FRAME_MEMBERS(X)                                                                       \
    GLBK_RSM_LIST_MEMBERS(X)                                                                            \
    GLBK_RSM_PICK_MEMBERS(X)                                                                            \
    GLBK_RSM_GRID_MEMBERS(X)                                                                            \
    GLBK_RSM_SHOW_MEMBERS(X)                                                                            \
    GLBK_RSM_SAMPLING_MEMBERS(X)                                                                        \
    GLBK_RSM_TEST_MEMBERS(X)

#define GLBK_RSM_OBJECT_MEMBERS(X)                                                                      \
    X(mat4, transform, 1)           /* object to world */                                               \
    X(mat4, clip, 1)                /* world to clip space of a face, or of the last frame */           \
    X(vec4, albedo, 1)              /* w is not used */                                                 \
    X(vec4, eye, 1)                 /* where the map is seen from; w = 0: a direction */

#define GLBK_RSM_SURFACE_MEMBERS(X)                                                                     \
    X(float, near_depth, 1)         /* least depth of the map */                                        \
    X(float, depth_scale, 1)        /* 1 / the map's range of depths */                                 \
    X(float, alpha_cutoff, 1)       /* less opaque texels are holes */                                  \
    X(uint, material, 1)            /* number of a Phong lobe, from 1; 0 = none */                      \
    X(uint, has_map, 1)             /* not 0: glbk_rsm_albedo_map is a factor of the albedo */          \
    X(uint, face, 1)                /* the face that is drawn */                                        \
    X(uint, unused0, 1)                                                                                 \
    X(uint, unused1, 1)

#define GLBK_RSM_DRAWN_MEMBERS(X) GLBK_RSM_OBJECT_MEMBERS(X) GLBK_RSM_SURFACE_MEMBERS(X)

/* One face that is imported. */
#define GLBK_RSM_IMPORTED_MEMBERS(X)                                                                    \
    X(mat4, to_world, 1)            /* the space of positions and normals to world */                   \
    X(vec4, color, 1)               /* a factor of colours; w is not used */                            \
    X(float, near_depth, 1)         /* of the map's light, like far_depth */                            \
    X(float, far_depth, 1)                                                                              \
    X(uint, face, 1)                                                                                    \
    X(uint, given, 1)               /* bits of rsm_import.frag: what there is */                        \
    X(uint, normal_packing, 1)      /* glbk_normal_packing */                                           \
    X(uint, material, 1)            /* number of a Phong lobe, from 1; 0 = none */                      \
    X(uint, left, 1)                /* texels of the textures from the left, and from the bottom, */    \
    X(uint, bottom, 1)              /* at which the face begins */                                      \
    X(uint, depth_layer, 1)         /* of arrays, like the others */                                    \
    X(uint, place_layer, 1)                                                                             \
    X(uint, normal_layer, 1)                                                                            \
    X(uint, color_layer, 1)                                                                             \
    X(uint, material_layer, 1)                                                                          \
    X(uint, unused0, 1)                                                                                 \
    X(uint, unused1, 1)                                                                                 \
    X(uint, unused2, 1)

#define GLBK_RSM_BLOCKS(X)                                                                              \
    X(glbk_rsm_light, 0, GLBK_RSM_LIGHT_MEMBERS)                                                        \
    X(glbk_rsm_frame, 1, GLBK_RSM_FRAME_MEMBERS)                                                        \
    X(glbk_rsm_drawn, 2, GLBK_RSM_DRAWN_MEMBERS)                                                        \
    X(glbk_rsm_imported, 2, GLBK_RSM_IMPORTED_MEMBERS)

#define GLBK_RSM_STORAGE(X)                                                                             \
    X(coherent, uint, glbk_rsm_counts, 0)   /* four of each list: groups in x, y, z; pixels */          \
    X(readonly, uint, glbk_rsm_items, 1)    /* a list: x | y << 16 */                                   \
    X(writeonly, uint, glbk_rsm_left, 2)    /* the list of pixels that stay pending */                  \
    X(writeonly, uint, glbk_rsm_wanted, 3)  /* the list of nodes that are wanted */                     \
    X(coherent, uint, glbk_rsm_marks, 4)    /* a bit for each node of the finest grid */

#define GLBK_RSM_IMAGES(X)                                                                              \
    X(restrict, rgba32f, image2D, glbk_rsm_picture, 0)                                                  \
    X(restrict, rgba32f, image2D, glbk_rsm_nodes, 1)    /* of the finest grid and all before it */      \
    X(restrict writeonly, r32ui, uimage2DArray, glbk_rsm_running, 2)

GLBK__PART(RSM)
