#ifndef GLBK_ISM_WITHOUT_CHOICE
/* ---- the next bounce on the GPU, from the maps (imperfect reflective shadow maps) ---- */

typedef struct glbk_ism_bounces {       /* what VPLs shine on, as a source; read only; zeroed = none */
    uint32_t     table;                 /* GL's name of the table of VPLs of the maps it was made for */
    uint32_t     side;                  /* cells a side of a VPL's tile */
    glbk_texture texels;                /* of glbk_ism_choose: side x side texels in the row of each VPL */
    glbk_target  target;                /* of texels */
    glbk_program program;
} glbk_ism_bounces;

GLBK_DEF glbk_result glbk_ism_bounces_create(glbk_context *ctx, const glbk_ism_maps *maps, uint32_t side,
                                             glbk_ism_bounces *out);
/* Makes room for the next bounce of the VPLs of maps, which must outlive it; glbk_ism_bounces_free takes it
   back.
   maps     made with desc.keep_hits. glbk_ism_mesh_upload gives them the albedos of the mesh
   side     a power of two, desc.tile_side at most: a VPL's tile is taken in side x side cells, each of which
            makes a texel of the next source
   out      zeroed on errors
   Memory   on the GPU: 48 bytes for each texel
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, maps were not created, or side is another.
            GLBK_ERR_MISMATCH: maps were made without desc.keep_hits. GLBK_ERR_LIMIT: side x side or
            vpl_count is above ctx->max_side. Those of programs, textures and targets */

GLBK_DEF glbk_result glbk_ism_bounce(glbk_context *ctx, glbk_ism_bounces *bounces, const glbk_ism_maps *maps);
/* Draws what the maps show into bounces->texels, a pass of fragments, as ism_bounce writes it: where light of
   the VPLs hits a triangle, with its normal towards the VPL, and the flux that the triangle's albedo
   leaves of it. glbk_ism_choose then chooses VPLs of the next bounce from these texels, for other maps, with
   a glbk_ism_choice_desc of width side x side, height desc.vpl_count and `scattered`.
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or an object was not created. GLBK_ERR_MISMATCH: maps are
            not those that the bounces were made for. GLBK_ERR_ORDER: the maps were never drawn, or not since
            the mesh has lost triangles. GLBK_ERR_LOST */

GLBK_DEF void glbk_ism_bounces_free(glbk_context *ctx, glbk_ism_bounces *bounces);
/* Frees what glbk_ism_bounces_create made, and zeroes the struct. NULL and zeroed bounces are allowed. */
#endif
