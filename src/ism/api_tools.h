#ifndef ISM_WITHOUT_SOURCES
/* ---- sources made for you ---- */

ISM_DEF ism_result ism_bounce(const ism_maps *maps, const ism_mesh *mesh, uint32_t side, float *positions,
                              float *normals, float *fluxes);
/* Writes a source of the next bounce: the surfaces that the VPLs' maps show, as imperfect reflective shadow
   maps. Give the source, which is scattered, to other maps. Texels that show nothing, and those of
   directions, have flux 0. desc.keep_hits must be set.
   mesh     that of the last ism_build
   side     texels a side that are taken of every tile, a power of two up to tile_side
   outputs  N * side * side * 3 floats each
   Errors   ISM_ERR_ARGUMENT: maps, which leaves no log, or another pointer is NULL, or side or a count or
            stride of the mesh is out of range.
            ISM_ERR_ORDER: ism_build must come first.
            ISM_ERR_MISMATCH: the maps were made without desc.keep_hits, or the mesh has not as many
            triangles as that of the last ism_build.
            ISM_ERR_INPUT: an index is not below vertex_count.
   Cost     O(N side^2 + triangles), on this thread, without progress */

ISM_DEF ism_result ism_emitter_points(const ism_mesh *mesh, const float *radiances, uint32_t count,
                                      uint32_t seed, const ism_system *system, float *positions,
                                      float *normals, float *fluxes);
/* Writes count points on emissive triangles: more where more power leaves (pi x radiance x area), each with
   an equal share of it. Make the points a scattered source of kind ISM_SOURCE_SURFACE.
   radiances  r, g, b of each triangle, 0..1e30 W/(sr m^2), else the triangle does not emit; the light leaves
              the side from which the triangle's corners are counter-clockwise
   count      above 0
   system     may be NULL
   outputs    count * 3 floats each
   Errors     ISM_ERR_ARGUMENT: a pointer is NULL, a count or stride is out of range, or there are no
              triangles.
              ISM_ERR_DESC: the allocator has one function of two.
              ISM_ERR_INPUT: an index is not below vertex_count, or no triangle emits.
              ISM_ERR_LIMIT: the mesh has 2^31 triangles or more.
              ISM_ERR_ALLOC: there is no memory. */

ISM_DEF ism_result ism_sky_directions(const float *texels, uint32_t width, uint32_t height, float rotation,
                                      float *directions, float *fluxes, uint64_t *bad_texels);
/* Writes a sky, given as a latitude-longitude map, as a source of ISM_SOURCE_DIRECTIONS. The first row of the
   map looks to +Y, its centre to +X, and +Z lies right of the centre.
   texels      radiance, 3 floats each; channels that are not finite or negative count as 0
   rotation    radians about +Y; in a scene with Z up turn the directions yourself
   outputs     width * height * 3 floats each; fluxes are radiance x the texel's exact solid angle
   bad_texels  how many texels had such channels; may be NULL
   Errors      this call has no log.
               ISM_ERR_ARGUMENT: a pointer is NULL, width or height is 0, or rotation is not finite. */
#endif

/* ---- where in a tile a direction lies: to read the atlas in code and shaders of your own ---- */

/* A direction is found in three steps: turn the direction into the VPL's axes, call ism_map_coordinates, and
   give the result to ism_zoom, which writes a place in the tile. ism_unzoom and ism_map_direction go back.
   The axis z is the VPL's normal. With ISM_PROJECTION_LOBE z is the VPL's lobe's axis; but tiles of VPLs with
   exponent 1 are of ISM_PROJECTION_COSINE then, with the normal as z.
   The axes x and y are made of z = (a, b, c) as by Duff et al., JCGT 6(1), 2017: with s = 1 if c >= 0 and
   else -1, and t = -1 / (s + c), x = (1 + s t a^2, s t a b, -s a) and y = (t a b, s + t b^2, -b).
   Tiles of directions are orthographic: a place that lies at (x, y, z) from ism_info.center, in these axes,
   has uv = 0.5 + 0.5 (x, y) / radius and the depth z + radius. */

ISM_DEF void ism_map_direction(ism_projection projection, float exponent, const float uv[2],
                               float direction[3]);
ISM_DEF int ism_map_coordinates(ism_projection projection, float exponent, const float direction[3],
                                float uv[2]);
/* ism_map_direction goes from a place in the unit square to a unit direction about +z; ism_map_coordinates
   goes back and returns 1. ism_map_coordinates returns 0, with uv untouched, for directions at or below the
   horizon (z <= 0). Corners of the PARABOLOID's square give directions below the horizon.
   Nothing is checked: pointers must not be NULL.
   exponent  0..1e5, of the VPL's lobe; read with ISM_PROJECTION_LOBE alone */

#ifndef ISM_WITHOUT_WINDOWS
ISM_DEF void ism_zoom(uint32_t window, uint32_t tile_side, uint32_t rim, const float uv[2], float tile[2]);
ISM_DEF void ism_unzoom(uint32_t window, uint32_t tile_side, uint32_t rim, const float tile[2], float uv[2]);
/* ism_zoom goes from a place in the square to its place in the tile, which is a unit square too; ism_unzoom
   goes back. The window is the part of the square that has all texels of the tile but `rim`; along each axis
   the map is linear below, in and above the window. Results are clamped to 0..1.
   window   ism_vpl.window: how many 64ths of the square lie below the window in u and in v, and above the
            window in u and in v, six bits each from the lowest on; 0 = the tile shows the square evenly
   rim      desc.window_rim, or its default if it is 0
   Pointers must not be NULL, and tile_side and rim be those of the maps: neither is checked. */
#endif

#ifdef __cplusplus
}
#endif

#endif /* ISM_H */
