#ifndef GLBK_ISM_WITHOUT_CHOICE
/* ---- VPLs chosen on the GPU, from maps that lie there: nothing is read back ---- */

#define GLBK_ISM_SUM_LEVELS 3u          /* levels of running sums, in blocks of 32 each */

typedef struct glbk_ism_choice_desc {   /* zero it, then set what you care about */
    uint32_t width;                     /* texels in a row of the source, 1..32768; must be set */
    uint32_t height;                    /* rows of a face; must be set. All faces have 32768 at most */
    uint32_t face_count;                /* such as the 6 of a cube map; 0 = 1 */
    int      scattered;                 /* not 0: neighbours in a face are no neighbours in space, so VPLs lie
                                           on texels, not between them */
} glbk_ism_choice_desc;

typedef struct glbk_ism_sheet {         /* numbers that a pass draws and later ones read; zeroed = none */
    glbk_texture texture;
    glbk_target  target;                /* of texture */
} glbk_ism_sheet;

typedef struct glbk_ism_choice {        /* what glbk_ism_choose needs; read only; zeroed = none */
    glbk_ism_choice_desc desc;          /* with its defaults */
    uint32_t       table;               /* GL's name of the table of VPLs that is drawn to */
    glbk_target    table_target;        /* of the table */
    glbk_ism_sheet boxes[3];            /* boxes about receivers: 1024 about 64 each, 32, and one about all; a
                                           layer for the lower corners, one for the upper ones */
    glbk_ism_sheet effects;             /* how much each texel of the source adds to the picture, face above
                                           face; R32UI, bits of floats */
    glbk_ism_sheet importances;         /* flux times effect, and flux; RG32UI, bits of floats, as sums */
    glbk_ism_sheet row_sums[GLBK_ISM_SUM_LEVELS];       /* running sums along rows: of each block of 32
                                                           texels, of each block of 32 blocks, of all of
                                                           these */
    glbk_ism_sheet column_sums[GLBK_ISM_SUM_LEVELS];    /* the same of whole rows, one texel wide */
    glbk_ism_sheet drawn;               /* VPLs, 256 a row: place and area; normal; flux */
    glbk_ism_sheet sights[2];           /* receivers that windows hold: pixels; places, normals */
    glbk_ism_sheet windows[2];          /* of tiles, 256 a row, in this frame and the one before */
    uint32_t       near_point_count;    /* near points that are drawn; 0 = none */
    glbk_ism_sheet near_points;         /* as they are drawn, 256 a row, like VPLs */
    glbk_ism_sheet near_sheets[2];      /* edges, reaches, VPLs, places on a curve; which one is when */
    uint32_t       turn;                /* frames that had windows; 0 = none yet. Odd: windows[1] is newer */
    glbk_buffer    block;               /* the uniform block */
    glbk_program   programs[13];        /* draw importances, running sums, VPLs and the table; effects, and
                                           boxes the first time and later; windows, and sights the same; near
                                           points' edges and the like, order and table */
} glbk_ism_choice;

GLBK_DEF glbk_result glbk_ism_choice_create(glbk_context *ctx, const glbk_ism_maps *maps,
                                            const glbk_ism_choice_desc *desc, glbk_ism_choice *out);
/* Makes what chooses the VPLs of maps, which must outlive it; glbk_ism_choice_free takes it back.
   maps     whose desc says how VPLs are chosen: vpl_count, importance, view_grid_side, blur_radius,
            flux_share, no_inter_texel, unstable, seed, window_rim, near_point_count and keep_hits count.
            There are near points unless vpl_count is 8 or less, or they and the VPLs are more than 2^20
            texels of the table
   out      zeroed on errors
   Memory   on the GPU: 20.5 bytes for each texel of the source (by flux 16.5), 80 for each VPL, 68
            for each near point, and 82 KB
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or maps were not created. GLBK_ERR_DESC: a field is out of
            range, also of maps->desc. GLBK_ERR_LIMIT: width, or the rows of all faces, are above
            ctx->max_side or 32768. Those of programs, textures and targets */

GLBK_DEF glbk_result glbk_ism_choose(glbk_context *ctx, glbk_ism_choice *choice, glbk_ism_maps *maps,
                                     const glbk_texture *texels, const glbk_gbuffer *seen, uint32_t index);
/* Chooses the VPLs of a frame as ism_choose does among surfaces, by passes of fragments, in place of
   glbk_ism_vpls_upload. Nothing is read back, and the CPU waits for nothing. All vpl_count VPLs are in use;
   those of a black source are black.
   maps     those of glbk_ism_choice_create. Near points are drawn with the VPLs; those of a texel without an
            area have one by how densely VPLs lie. Tiles have windows (ism_zoom) by what seen shows, as after
            ism_scatter
   texels   the source: RGBA32UI layers, three for each face, with the bits of floats: place; unit normal;
            flux of the channels in W, and area in m^2 (what ism_source says of them). glbk_rsm_map.texels are
            such. A texel whose flux is not 0..1e30, whose place is not finite or whose normal is not unit is
            never chosen
   seen     what the camera sees: the receivers, and the matrix that says which of them lie near a texel and
            how far VPLs may move between texels. If the G-buffer has no matrix (has_clip is 0), receivers
            are looked for everywhere alike, and VPLs may move as far as if all was seen from afar. May be
            NULL with ISM_IMPORTANCE_FLUX; tiles have no windows then
   index    number of the frame; counts if maps->desc.unstable is set
   Cost     for each texel of the source 35 texels read by flux; else besides view_grid_side^2 receivers, and
            three texels for each that its blur reaches, 169 by default. Each VPL looks at all others, and for
            its window at 512 receivers, which are found among all pixels; each near point looks at all VPLs
            and at 1023 others
   Errors   GLBK_ERR_ARGUMENT: a pointer that must be given is NULL, or an object was not created.
            GLBK_ERR_MISMATCH: maps are not those that the choice was made for, or texels have another size,
            format or number of layers. GLBK_ERR_LOST */

GLBK_DEF void glbk_ism_choice_free(glbk_context *ctx, glbk_ism_choice *choice);
/* Frees what glbk_ism_choice_create made, and zeroes the struct. NULL and a zeroed choice are allowed. */
#endif
