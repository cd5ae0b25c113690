/* ---- page one: the maps of all VPLs, drawn from ism.h's lists, for a shader of yours ---- */

typedef struct glbk_ism_maps glbk_ism_maps;             /* the maps of all VPLs: see "objects" below */
typedef struct glbk_ism_renderer glbk_ism_renderer;     /* the light of a picture: see there, too */

GLBK_DEF glbk_result glbk_ism_maps_create(glbk_context *ctx, const ism_desc *desc, glbk_ism_maps *out);
/* Makes room for the maps of all VPLs, which glbk_ism_maps_free takes back. out->compute says whether they
   are drawn by compute: if ctx->compute is set, unless the surfels of a VPL, rounded up to lazy_frames
   phases, are more than 65,536.
   desc     the desc of the ism_create whose lists are drawn; NULL = all defaults. vpl_count, surfel_count,
            tile_side, projection, lazy_frames, splat_scale, near_point_count, window_rim, keep_hits and
            no_fill count. With keep_hits the core path draws, and 4 bytes for each texel are added.
            The other fields, also its system, say how ism.h chooses the lists and play no part here
   out      zeroed on errors
   Memory   on the GPU: 26 bytes for each texel of the atlas, by compute 20, and 16 for each surfel. 1024 VPLs
            with 64 x 64 texels and 8192 surfels take 109 (84) + 134 MB
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range. GLBK_ERR_LIMIT: the
            atlas is wider than ctx->max_side. Those of programs, textures and targets */

GLBK_DEF glbk_result glbk_ism_mesh_upload(glbk_context *ctx, glbk_ism_maps *maps, const ism_mesh *mesh);
/* Sets the mesh that casts shadows. Surfels stay on triangles of the same numbers; those on triangles that
   are gone are not drawn. Before a mesh with other numbers set NULL: all phases must be given anew then.
   mesh     NULL = nothing casts shadows; its albedos are for glbk_ism_bounce, with desc.keep_hits. Its
            opacities are not checked here, as ism_build checks them
   Errors   GLBK_ERR_ARGUMENT: maps is NULL or was not created, or arrays, counts or strides do not fit.
            GLBK_ERR_INPUT: an index reaches beyond vertex_count. GLBK_ERR_LIMIT, GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_ism_surfels_upload(glbk_context *ctx, glbk_ism_maps *maps, uint32_t phase,
                                             const ism_surfel *surfels, size_t count);
/* Sets the surfels of one phase, of all VPLs, as ism_phase_surfels writes them.
   phase    below lazy_frames. A frame changes the phase index % lazy_frames alone. All of them are needed in
            the first frame, where the mesh has lost triangles, and with vary_surfels and unstable
   surfels  VPL by VPL
   count    surfels of the phase, as ism_phase_surfels counts them: desc.vpl_count x maps->phase_surfel_count
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, maps were not created, or there is no such phase.
            GLBK_ERR_MISMATCH: count is another, since ism_create and glbk_ism_maps_create were given
            different descs */

GLBK_DEF glbk_result glbk_ism_vpls_upload(glbk_context *ctx, glbk_ism_maps *maps, const ism_vpl *vpls,
                                          uint32_t count, const ism_info *info);
/* Sets the VPLs of a frame. They have no near points until glbk_ism_near_points_upload.
   vpls     as ism_vpls has them; area, source, texel and jumped play no part
   count    at most desc.vpl_count; 0 = no light
   info     what ism_get_info writes of the ism_maps whose VPLs these are, after ism_scatter. The maps of
            directional VPLs show the sphere of info->center and info->radius. surfel_count, tile_side and
            lazy_frames must be those of maps->desc; in a struct of your own, for VPLs of your own, they may
            be 0
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or maps were not created. GLBK_ERR_INPUT: a VPL that
            ism_set_vpls refuses, a negative edge or reach, a window that leaves nothing of a side, or a
            radius of 0 beside a directional VPL. GLBK_ERR_LIMIT: count is above desc.vpl_count.
            GLBK_ERR_MISMATCH: info is of an ism_create with another desc. GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_ism_draw(glbk_context *ctx, glbk_ism_maps *maps, uint32_t surfels_per_pass);
/* Draws the maps of all VPLs, to maps->atlas: depths, as bits of floats, tile by tile. The core path takes a
   draw for each phase, or for each surfels_per_pass of it, and then up to five passes over the atlas. The
   compute path takes two dispatches. If ctx->max_point_side is below tile_side, the core path draws
   rectangles instead of points.
   surfels_per_pass   most surfels of a draw on the core path; 0 = 2^20. Give fewer if the driver stops draws
                      that take long
   Errors             GLBK_ERR_ARGUMENT: maps is NULL or was not created. GLBK_ERR_ORDER: the surfels of a
                      phase were not given yet. GLBK_ERR_LOST */

GLBK_DEF glbk_result glbk_ism_bind(glbk_context *ctx, const glbk_ism_maps *maps, const ism_shading *shading,
                                   const glbk_offset *offset);
/* Binds textures and uniform blocks for a program of your own, which is in use (glbk_begin). The program has
   ism_light among its library files, and among its defines ISM_NEAR, the number of a near_mode (0 and 6 are
   ISM_NEAR_GATHER), and ISM_PROJECTION, the number of maps->desc.projection.
   shading  NULL = all defaults; only bias, clamp and no_maps count, but all fields are checked, and
            visible_fn and near_visible_fn must be NULL
   offset   the offset that the part ism has in the program; NULL = none
   Errors   GLBK_ERR_ARGUMENT: maps is NULL or was not created. GLBK_ERR_DESC: a field of the shading is out
            of range, or a function is not NULL */

GLBK_DEF void glbk_ism_maps_free(glbk_context *ctx, glbk_ism_maps *maps);
/* Frees what glbk_ism_maps_create made, and zeroes the struct. NULL and zeroed maps are allowed. */
