/* ---- sources made for you ---- */

ISM_DEF ism_result ism_bounce(const ism_maps *maps, const ism_mesh *mesh, uint32_t side, float *positions,
                              float *normals, float *fluxes);
/* Writes a source of the next bounce, from imperfect reflective shadow maps: side x side texels of every tile
   (side a power of two up to tile_side), N * side * side of 3 floats each, scattered. Texels that show
   nothing, and those of directions, have flux 0. Give them to other maps as a source. desc.keep_hits must be
   set, and mesh must be that of the last ism_build.
   Errors   ISM_ERR_ARGUMENT, ISM_ERR_ORDER, ISM_ERR_MISMATCH (another number of triangles), ISM_ERR_INPUT (an
            index beyond vertex_count)
   Cost     O(N side^2 + triangles), on this thread, without progress */

ISM_DEF ism_result ism_emitter_points(const ism_mesh *mesh, const float *radiances, uint32_t count,
                                      uint32_t seed, const ism_system *system, float *positions,
                                      float *normals, float *fluxes);
/* Writes count points on emissive triangles, in proportion to their power, with equal shares: flux = pi x
   radiance x area. Make them a scattered source of kind ISM_SOURCE_SURFACE.
   radiances  r, g, b of each triangle, W/(sr m^2); it emits from the side that its corners turn round
              counter-clockwise
   outputs    count * 3 floats each
   Errors     ISM_ERR_ARGUMENT, ISM_ERR_INPUT (as ism_build; no triangle emits), ISM_ERR_LIMIT,
              ISM_ERR_ALLOC */

ISM_DEF ism_result ism_sky_directions(const float *texels, uint32_t width, uint32_t height, float rotation,
                                      float *directions, float *fluxes, uint64_t *bad_texels);
/* Writes a latitude-longitude map (row 0 is +Y, its centre +X, +Z right of it) as a source of
   ISM_SOURCE_DIRECTIONS.
   texels      r, g, b, radiance; channels that are not finite or negative count as 0 and are counted in
               bad_texels, which may be NULL
   rotation    radians about +Y; of scenes with Z up turn the directions yourself
   outputs     width * height * 3 floats each; fluxes are radiance x the texel's exact solid angle
   Errors      ISM_ERR_ARGUMENT */

/* ---- formulas: for tests, and for shaders of your own ---- */

ISM_DEF void ism_map_direction(ism_projection projection, float exponent, const float uv[2],
                               float direction[3]);
ISM_DEF int ism_map_coordinates(ism_projection projection, float exponent, const float direction[3],
                                float uv[2]);
/* Go between the unit square and unit directions about +z; exponent is asked of ISM_PROJECTION_LOBE alone.
   The second returns 0, uv untouched, for directions at or below the horizon (z <= 0). Corners of PARABOLOID
   give directions below it. */

ISM_DEF void  ism_zoom(uint32_t window, uint32_t tile_side, uint32_t rim, const float uv[2], float tile[2]);
ISM_DEF void  ism_unzoom(uint32_t window, uint32_t tile_side, uint32_t rim, const float tile[2], float uv[2]);
/* Go between that square and the tile that shows it, also a unit square, for a VPL's window and window_rim
   texels of rim: in each axis linear below, in and above the window, which has all texels but `rim`. Both
   clamp to 0..1.
   window   how many 64ths of the square lie below it in u and in v, and above it in u and in v, six bits each
            from the lowest on; 0 is the whole square: the tile is the square */

ISM_DEF float ism_solid_angle(const float a[3], const float b[3], const float c[3]);
/* Returns the solid angle of a triangle seen from the origin, in sr, exact (Van Oosterom and Strackee 1983);
   0 if it is degenerate. */

ISM_DEF float ism_form_factor(const float normal[3], const float corners[12]);
/* Returns the form factor from a point at the origin to a flat quadrilateral, clipped at the point's horizon
   (Lambert). Corners go counter-clockwise as seen from the point, else the result is 0. */

ISM_DEF int   ism_dither(uint32_t x, uint32_t y, float opacity);
/* Returns 1 if a pixel of this opacity is to be drawn: of each 2 x 2 pixels opacity 0, .25, .5, .75, 1 draws
   exactly 0 to 4 (section 6.4). */

#ifdef __cplusplus
}
#endif

#endif /* ISM_H */
