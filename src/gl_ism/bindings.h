/* ---- what the GLSL declares; see "bindings" in gl_programs.h ---- */

#define GLBK_ISM_TABLES(X)                                                                              \
    X(usampler2DArray, glbk_ism_vpls, 0)        /* VPLs and near points: docs/gpu-layouts.md */         \
    X(usampler2DArray, glbk_ism_surfels, 1)     /* triangle, barycentric coordinates, area */           \
    X(sampler2DArray, glbk_ism_albedos, 1)      /* of triangles */                                      \
    X(usampler2DArray, glbk_ism_triangles, 2)   /* of each three indices, opacity */                    \
    X(sampler2DArray, glbk_ism_positions, 3)    /* of vertices */

#define GLBK_ISM_PICTURES(X)                                                                            \
    X(usampler2D, glbk_ism_atlas, 4)            /* depths, floats as bits */                            \
    X(glbk_color_sampler, glbk_ism_planes, 5)   /* plane and depth of a texel's nearest surfel */       \
    X(usampler2D, glbk_ism_below, 6)            /* kept texels, or the level below */                   \
    X(usampler2D, glbk_ism_hits, 7)             /* triangle of a texel's nearest surfel */              \
    X(glbk_color_sampler, glbk_ism_light, 7)    /* irradiance; 8 to 11 are the G-buffer's */            \
    X(usampler2D, glbk_ism_pull1, 12)           /* levels of pull, whose slots are neighbours */        \
    X(usampler2D, glbk_ism_pull2, 13)                                                                   \
    X(usampler2D, glbk_ism_pull3, 14)

/* Of programs that choose VPLs, which read neither tables nor maps. */
#define GLBK_ISM_CHOICE_TEXTURES(X)                                                                     \
    X(usampler2DArray, glbk_ism_texels, 0)      /* layers 3 face + 0 place, 1 normal, 2 flux */         \
    X(usampler2DArray, glbk_ism_near, 0)        /* near points: place, normal, flux */                  \
    X(usampler2D, glbk_ism_near_order, 1)       /* which near point has a place in their order */       \
    X(usampler2D, glbk_ism_near_facts, 2)       /* of near points: edge, reach, VPL, place on a curve */ \
    X(usampler2DArray, glbk_ism_drawn, 1)       /* VPLs: place, normal, flux */                         \
    X(usampler2DArray, glbk_ism_box, 1)         /* of the receivers: lower and upper corner */          \
    X(usampler2D, glbk_ism_effects, 1)          /* of texels on the picture */                          \
    X(usampler2D, glbk_ism_summed, 1)           /* values of running sums */                            \
    X(usampler2D, glbk_ism_importances, 1)      /* flux times effect, flux */                           \
    X(usampler2D, glbk_ism_row_sums0, 2)        /* running sums of importances along rows */            \
    X(usampler2D, glbk_ism_row_sums1, 3)        /* and of their blocks of 32 */                         \
    X(usampler2D, glbk_ism_row_sums2, 4)        /* and of blocks of these */                            \
    X(usampler2D, glbk_ism_column_sums0, 5)     /* the same of whole rows */                            \
    X(usampler2D, glbk_ism_column_sums1, 6)                                                             \
    X(usampler2D, glbk_ism_column_sums2, 7)                                                             \
    X(usampler2DArray, glbk_ism_sights, 12)     /* receivers that lie farthest out */                   \
    X(usampler2D, glbk_ism_windows, 13)         /* of VPLs: place; window and face */

/* Of programs that scatter surfels. */
#define GLBK_ISM_SPREAD_TEXTURES(X)                                                                     \
    X(usampler2D, glbk_ism_values, 1)           /* sequences that are summed up */                      \
    X(usampler2DArray, glbk_ism_clusters, 1)    /* of triangles: place; squares of normals */           \
    X(usampler2D, glbk_ism_shares, 1)           /* of the surfels of VPLs that clusters have */         \
    X(usampler2D, glbk_ism_gone, 2)             /* which surfels' triangles are gone */                 \
    X(usampler2D, glbk_ism_runs0, 4)            /* running sums in blocks of 32, */                     \
    X(usampler2D, glbk_ism_runs1, 5)            /* of 32 blocks, and so on: of shares, */               \
    X(usampler2D, glbk_ism_runs2, 6)            /* or of receivers, which have five levels */           \
    X(usampler2D, glbk_ism_runs3, 7)                                                                    \
    X(usampler2D, glbk_ism_effect_totals, 4)    /* sums of what VPLs see of clusters */                 \
    X(usampler2D, glbk_ism_totals, 7)           /* area and solid angle of all triangles */             \
    X(usampler2D, glbk_ism_runs4, 12)                                                                   \
    X(usampler2D, glbk_ism_counts, 12)          /* surfels of each VPL */                               \
    X(usampler2D, glbk_ism_receivers, 13)       /* places of receivers */                               \
    X(usampler2D, glbk_ism_masses, 13)          /* of clusters: area and solid angle */                 \
    X(usampler2D, glbk_ism_sizes, 14)           /* of triangles: area and solid angle */

#define GLBK_ISM_TEXTURES(X)                                                                            \
    GLBK_ISM_TABLES(X) GLBK_ISM_PICTURES(X) GLBK_ISM_CHOICE_TEXTURES(X) GLBK_ISM_SPREAD_TEXTURES(X)

#define GLBK_ISM_COUNT_MEMBERS(X)                                                                       \
    X(uint, vpl_count, 1)           /* VPLs in use */                                                   \
    X(uint, tile_side, 1)           /* texels a side of a VPL's tile */                                 \
    X(uint, tiles_across, 1)        /* tiles a side of the atlas */                                     \
    X(uint, surfel_count, 1)        /* surfels of a VPL, in all phases */                               \
    X(uint, vpl_capacity, 1)        /* VPLs that there is room for */                                   \
    X(uint, phase_surfel_count, 1)  /* surfels of a VPL in one phase */                                 \
    X(uint, fill_levels, 1)         /* levels of pull and push; 0 = holes stay */                       \
    X(uint, triangle_count, 1)

#define GLBK_ISM_MESH_MEMBERS(X)                                                                        \
    X(vec4, sphere, 1)              /* about the mesh: centre, radius */                                \
    X(float, splat_scale, 1)        /* area of a disc over that of its surfel */                        \
    X(uint, window_rim, 1)          /* texels a side of a tile outside of its window */                 \
    X(uint, near_point_count, 1)    /* near points in use */                                            \
    X(uint, first_sphere, 1)        /* where in glbk_ism_vpls spheres of near points begin */           \
    X(uint, first_near_point, 1)    /* where in glbk_ism_vpls near points begin */                      \
    X(uint, first_surfel, 1)        /* of a draw of rectangles: the surfel of instance 0 */             \
    X(uint, bounce_side, 1)         /* cells a side of a tile that glbk_ism_bounce reads */             \
    X(uint, unused0, 1)

#define GLBK_ISM_FRAME_MEMBERS(X) GLBK_ISM_COUNT_MEMBERS(X) GLBK_ISM_MESH_MEMBERS(X)

#define GLBK_ISM_VIEW_MEMBERS(X)                                                                        \
    X(uint, width, 1)               /* of the picture, in pixels */                                     \
    X(uint, height, 1)              /* of the picture, in pixels */                                     \
    X(uint, interleave, 1)          /* pixels a side that share the VPLs */                             \
    X(uint, no_maps, 1)             /* not 0: nothing casts shadows */                                  \
    X(float, bias, 1)               /* as in ism_shading, with its default */                           \
    X(float, clamp_at, 1)           /* ism_shading.clamp, with its default */                           \
    X(uint, first_row, 1)           /* the first row of pixels of a dispatch */                         \
    X(uint, unused0, 1)

#define GLBK_ISM_CHOOSING_MEMBERS(X)                                                                    \
    X(mat4, world_to_clip, 1)       /* of the camera; 0 = unknown */                                    \
    X(uint, width, 1)               /* texels in a row of the source */                                 \
    X(uint, face_height, 1)         /* rows of a face */                                                \
    X(uint, vpl_count, 1)           /* VPLs that are chosen */                                          \
    X(uint, inter_texel, 1)         /* not 0: VPLs lie between texels */                                \
    X(float, shift, 1)              /* added to the places of VPLs in the sums of rows */               \
    X(uint, shift_bits, 1)          /* the same in a row, as a fraction of 2^32 */                      \
    X(uint, columns, 1)             /* of running sums: not 0 = along columns */                        \
    X(uint, pace, 1)                /* of running sums: values from one that counts to the next */      \
    X(uint, value_count, 1)         /* of running sums: values in a row or column */                    \
    X(uint, first_column, 1)        /* of running sums along columns: where they are read */            \
    X(uint, view_width, 1)          /* of the picture, in pixels */                                     \
    X(uint, view_height, 1)         /* of the picture, in pixels */                                     \
    X(uint, grid_side, 1)           /* ism_desc.view_grid_side */                                       \
    X(uint, guided, 1)              /* not 0: half of the receivers lie near the texel's own place */   \
    X(uint, by_effect, 1)           /* not 0: effects count; 0: flux alone */                           \
    X(uint, by_mean, 1)             /* not 0: effects are means; 0: roots of mean squares */            \
    X(uint, blur_radius, 1)         /* of effects, in texels */                                         \
    X(uint, seed, 1)                /* of receivers */                                                  \
    X(float, flux_factor, 1)        /* what makes ism_desc.flux_share of a factor of fluxes */          \
    X(uint, windows, 1)             /* 0 = none; 1 = new ones; 2 = those of the last frame stay */      \
    X(uint, near_point_count, 1)    /* near points that are drawn; 0 = none */                          \
    X(uint, first_sphere, 1)        /* where in glbk_ism_vpls their spheres begin */                    \
    X(uint, first_near_point, 1)    /* where they begin themselves; 0 while VPLs are drawn */           \
    X(uint, unused0, 1)

#define GLBK_ISM_SCATTERING_MEMBERS(X)                                                                  \
    X(uint, triangle_count, 1)      /* of the mesh */                                                   \
    X(uint, cluster_count, 1)       /* clusters of triangles */                                         \
    X(uint, cluster_size, 1)        /* triangles of a cluster */                                        \
    X(uint, first_vpl, 1)           /* of the batch */                                                  \
    X(uint, batch, 1)               /* VPLs that are worked on */                                       \
    X(uint, vpl_capacity, 1)        /* VPLs that there is room for */                                   \
    X(uint, view_width, 1)          /* of the picture, in pixels */                                     \
    X(uint, view_height, 1)         /* of the picture, in pixels */                                     \
    X(uint, views, 1)               /* receivers of a triangle; 0 = by area */                          \
    X(uint, pair, 1)                /* not 0: what a VPL sees of a cluster counts */                    \
    X(uint, seed, 1)                /* of receivers */                                                  \
    X(uint, key, 1)                 /* of surfels */                                                    \
    X(uint, surfel_count, 1)        /* of each VPL, in all phases */                                    \
    X(uint, phase_surfel_count, 1)  /* of each VPL in one phase */                                      \
    X(uint, lazy_frames, 1)         /* phases */                                                        \
    X(uint, phase, 1)               /* that is drawn */                                                 \
    X(uint, first_texel, 1)         /* number of the layer's first texel among a phase's surfels */     \
    X(uint, value_count, 1)         /* of a sequence that is summed up */                               \
    X(uint, pace, 1)                /* values from one that counts to the next */                       \
    X(uint, vary_surfels, 1)        /* not 0: dark VPLs have fewer surfels */                           \
    X(float, area_share, 1)         /* ism_desc.area_share, with its default */                         \
    X(uint, frame, 1)               /* its number */                                                    \
    X(uint, keep, 1)                /* not 0: surfels stay whose triangles are there */                 \
    X(uint, layer, 1)               /* of the table of surfels, that is drawn */

#define GLBK_ISM_BLOCKS(X)                                                                              \
    X(glbk_ism_frame, 0, GLBK_ISM_FRAME_MEMBERS)                                                        \
    X(glbk_ism_view, 1, GLBK_ISM_VIEW_MEMBERS)                                                          \
    X(glbk_ism_choosing, 2, GLBK_ISM_CHOOSING_MEMBERS)                                                  \
    X(glbk_ism_scattering, 3, GLBK_ISM_SCATTERING_MEMBERS)

#define GLBK_ISM_STORAGE(X)
#define GLBK_ISM_IMAGES(X)                                                                              \
    X(writeonly, rgba32f, image2D, glbk_ism_planes_out, 0)      /* glbk_ism_planes */                   \
    X(writeonly, r32ui, uimage2D, glbk_ism_atlas_out, 1)        /* glbk_ism_atlas */                    \
    X(writeonly, rgba32f, image2D, glbk_ism_light_out, 2)       /* before the blur, or after it */

GLBK__PART(ISM)
