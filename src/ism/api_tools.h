#ifndef ISM_WITHOUT_SOURCES
/* ---- sources made for you ---- */

ISM_DEF ism_result ism_bounce(const ism_maps *maps, const ism_mesh *mesh, uint32_t side, float *positions,
                              float *normals, float *fluxes);
/* Writes a source of the next bounce: what the VPLs' maps show, as imperfect reflective shadow maps. Give the
   source, which is scattered, to other maps. Texels that show nothing, and those of directions, have flux 0.
   desc.keep_hits must be set.
   mesh     that of the last ism_build
   side     texels a side that are taken of every tile, a power of two up to tile_side
   outputs  N * side * side * 3 floats each
   Errors   ISM_ERR_ARGUMENT, ISM_ERR_ORDER (no maps were built, no keep_hits), ISM_ERR_MISMATCH (another
            number of triangles), ISM_ERR_INPUT (an index beyond vertex_count)
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
   Errors     ISM_ERR_ARGUMENT, ISM_ERR_INPUT (as ism_build; no triangle emits), ISM_ERR_LIMIT,
              ISM_ERR_ALLOC */

ISM_DEF ism_result ism_sky_directions(const float *texels, uint32_t width, uint32_t height, float rotation,
                                      float *directions, float *fluxes, uint64_t *bad_texels);
/* Writes a sky, given as a latitude-longitude map, as a source of ISM_SOURCE_DIRECTIONS. The first row of the
   map looks to +Y, its centre to +X, and +Z lies right of the centre.
   texels      radiance, 3 floats each; channels that are not finite or negative count as 0
   rotation    radians about +Y; in a scene with Z up turn the directions yourself
   outputs     width * height * 3 floats each; fluxes are radiance x the texel's exact solid angle
   bad_texels  how many texels had such channels; may be NULL
   Errors      ISM_ERR_ARGUMENT */
#endif

/* ---- where in a tile a direction lies: to read the atlas in code and shaders of your own ---- */

/* world direction -> local direction -> ism_map_coordinates -> ism_zoom -> place in the tile, and back by
   ism_unzoom and ism_map_direction. The local axis z is the VPL's normal; with ISM_PROJECTION_LOBE it is the
   VPL's axis, and VPLs with exponent 1 have ISM_PROJECTION_COSINE. For z = (a, b, c), with s = 1 if c >= 0
   and else -1, and t = -1 / (s + c), the other axes are x = (1 + s t a^2, s t a b, -s a) and y = (t a b, s +
   t b^2, -b) (Duff et al., JCGT 6(1), 2017). Tiles of directions are orthographic: a place (x, y,
   z) from ism_info.center lies at uv = 0.5 + 0.5 (x, y) / radius, at the depth z + radius. */

ISM_DEF void ism_map_direction(ism_projection projection, float exponent, const float uv[2],
                               float direction[3]);
ISM_DEF int ism_map_coordinates(ism_projection projection, float exponent, const float direction[3],
                                float uv[2]);
/* Go from the unit square to unit directions about +z, and back. exponent is read by ISM_PROJECTION_LOBE
   alone. The second returns 0, with uv untouched, for directions at or below the horizon (z <= 0). Corners of
   the PARABOLOID give directions below it. */

ISM_DEF void ism_zoom(uint32_t window, uint32_t tile_side, uint32_t rim, const float uv[2], float tile[2]);
ISM_DEF void ism_unzoom(uint32_t window, uint32_t tile_side, uint32_t rim, const float tile[2], float uv[2]);
/* Go from that square to the tile that shows it, which is a unit square too, and back. The window is the part
   of the square that has all texels of the tile but `rim`; in each axis the way is linear below, in and above
   the window. Both clamp to 0..1.
   window   ism_vpl.window: how many 64ths of the square lie below the window in u and in v, and above it in u
            and in v, six bits each from the lowest on; 0 = the whole square, which is then the tile
   rim      desc.window_rim, or what it is by default */

#ifdef __cplusplus
}
#endif

#endif /* ISM_H */
