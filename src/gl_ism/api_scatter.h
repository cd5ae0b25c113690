#ifndef GLBK_ISM_WITHOUT_CHOICE
/* ---- surfels scattered on the GPU: with glbk_ism_choose, nothing of a frame comes from the CPU ---- */

typedef struct glbk_ism_spread {        /* what glbk_ism_scatter needs; read only; zeroed = none */
    uint32_t table;                     /* GL's name of the table of VPLs of the maps it was made for */
    uint32_t width, height;             /* of the picture that it has room for; 0 = none yet */
    uint32_t triangle_count;            /* of the mesh that it has room for; 0 = none yet */
    uint32_t cluster_count;             /* clusters are successive triangles that are taken together */
    uint32_t triangles_per_cluster;     /* of each cluster but the last */
    uint32_t batch;                     /* VPLs whose shares are computed at a time */
    glbk_ism_sheet seen;                /* 1 for each pixel that is a receiver; R32UI, bits of floats */
    glbk_ism_sheet seen_sums[5];        /* running sums of these, in blocks of 32, of 32 blocks, ... */
    glbk_ism_sheet receivers;           /* places of receivers, one after the other; RGBA32UI */
    glbk_ism_sheet sizes;               /* of triangles: area and solid angle; RG32UI */
    glbk_ism_sheet masses;              /* of clusters, the same; the target draws `clusters`, too */
    glbk_texture   clusters;            /* where clusters lie and how they face, three layers of RGBA32UI */
    glbk_ism_sheet totals[3];           /* sums of masses, in blocks of 32, of 32 blocks, of all */
    glbk_ism_sheet effects;             /* of clusters on the maps of a batch of VPLs; R32UI */
    glbk_ism_sheet effect_totals[3];    /* sums of effects */
    glbk_ism_sheet shares;              /* of the surfels of VPLs that clusters have; R32UI */
    glbk_ism_sheet share_sums[3];       /* running sums of shares */
    glbk_ism_sheet counts;              /* surfels of each VPL; R32UI, whole numbers */
    glbk_ism_sheet gone;                /* 1 for each surfel whose triangle is gone, in the rows of a layer
                                           that are drawn next; R8UI */
    glbk_target    surfel_target;       /* of a layer of the maps' tables of surfels */
    glbk_buffer    block;               /* the uniform block */
    glbk_program   programs[10];        /* draw sizes, masses, shares, sums, counts, surfels and which are
                                           gone, then seen and receivers, then effects */
} glbk_ism_spread;

GLBK_DEF glbk_result glbk_ism_spread_create(glbk_context *ctx, const glbk_ism_maps *maps,
                                            glbk_ism_spread *out);
/* Makes what scatters the surfels of maps, which must outlive it; glbk_ism_spread_free takes it back. What
   depends on the mesh and on the picture is made by glbk_ism_scatter.
   maps     whose desc says how surfels are scattered: surfel_count, spread, lazy_frames, area_share,
            unstable, vary_surfels, window_rim and seed count
   out      zeroed on errors
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or maps were not created. GLBK_ERR_DESC: maps->desc.spread
            or area_share is out of range. Those of programs, textures and targets */

GLBK_DEF glbk_result glbk_ism_scatter(glbk_context *ctx, glbk_ism_spread *spread, glbk_ism_maps *maps,
                                      const glbk_gbuffer *seen, uint32_t index);
/* Scatters the surfels of a frame as ism_scatter does for the same random numbers, by passes of fragments, in
   place of glbk_ism_surfels_upload: the surfels of phase index % lazy_frames, and at first, or with unstable
   or vary_surfels, those of all phases. If the mesh has lost triangles, surfels that lay on them are
   scattered anew in all phases, and the others stay; new triangles get theirs phase by phase. Sums are of
   floats where ism_scatter has doubles, so a surfel beside the step of a sum may lie on a neighbouring
   triangle. Nothing is read back, and the CPU waits for nothing. Triangles and vertices are those that the
   maps have there.
   maps     those of glbk_ism_spread_create, with a mesh that has no mask, whose holes the GPU does not know,
            and with VPLs: glbk_ism_choose or glbk_ism_vpls_upload. Without triangles nothing is done
   seen     what the camera sees: the receivers. May be NULL with ISM_SPREAD_AREA
   index    number of the frame
   Memory   on the GPU: 8 bytes for each triangle, 56 for each of at most 32,768 clusters, 24.2 for each
            pixel, 26 MB at most for the shares of a batch of VPLs, and 1 MB
   Cost     for each triangle 8 receivers, with ISM_SPREAD_VIEW_1 one; for each VPL, by ISM_SPREAD_PAIR, every
            cluster; for each surfel 16 texels and half the triangles of a cluster
   Errors   GLBK_ERR_ARGUMENT: a pointer that must be given is NULL, or an object was not created.
            GLBK_ERR_MISMATCH: maps are not those that the spread was made for, or their mesh has a mask.
            GLBK_ERR_LIMIT: the picture has more than 2^24 pixels, or there are so many of them, or of
            triangles, that 1024 in a row are more rows than ctx->max_side. GLBK_ERR_ALLOC, GLBK_ERR_LOST */

GLBK_DEF void glbk_ism_spread_free(glbk_context *ctx, glbk_ism_spread *spread);
/* Frees what glbk_ism_spread_create and glbk_ism_scatter made, and zeroes the struct. NULL and a zeroed
   spread are allowed. */
#endif
