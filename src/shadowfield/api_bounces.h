/* ---- one interreflection between bodies ---- */

#ifndef SFIELD_WITHOUT_BUILD
typedef struct sfield_bounce sfield_bounce;     /* what a diffuse body sends on of the light that it gets */

SFIELD_DEF sfield_result sfield_bounce_create(const sfield_desc *desc, const sfield_mesh *mesh,
                                              const float *albedo, uint32_t patch_count, sfield_bounce **out);
/* Cuts the surface of a body into patches and builds a source field of each, once for each body. Then, in
   each frame: shade the points of all bodies, give each body its results (sfield_bounce_update), let its
   entity have the source (sfield_bounce_source, tint 1 1 1), and shade what is to be seen. The body's own
   points are not lit by its source. If the entities had the sources of the last frame when the points were
   shaded, each frame adds a bounce; for one bounce alone give the scene entities without these sources first.
   desc         as for the body's occlusion field; harmonics, of visibility. A shell_count and position_side
                of 8 are enough, since what bodies send on is soft. Frames and shards are not read
   mesh         the body. Light leaves the side from which corners are counter-clockwise. A triangle belongs
                to one patch: what is large has to be cut
   albedo       r, g, b of each triangle, 0..1
   patch_count  1..192; 0 = 24. There may be fewer, if triangles are few
   out          written on SFIELD_OK only; sfield_bounce_free takes the bounce back
   Errors       as sfield_build_emissive; SFIELD_ERR_ARGUMENT also for patch_count and NULL, SFIELD_ERR_INPUT
                for an albedo and for a mesh without an area, SFIELD_ERR_DESC also for wavelets and logarithms
   Cost         a source field for every three patches, in time and memory: for each patch shells x
                6 side^2 x n bytes, with n = bands^2 filled up to a multiple of 8. Beside them the source,
                which is as large as three patches, and 72 side^2 x n bytes */

SFIELD_DEF void sfield_bounce_free(sfield_bounce *bounce);
/* Takes back a body's patches and their source. Accepts NULL. */

SFIELD_DEF void sfield_bounce_points(const sfield_bounce *bounce, sfield_points *out);
/* Writes the receivers at which light has to be known, four a patch: count, positions and normals in the
   space of the body; all else is 0. Set `entity` and `rgb`, and `self` for a body that hides something of
   itself. If bounce or out is NULL, nothing is written. */

SFIELD_DEF sfield_result sfield_bounce_update(sfield_bounce *bounce, const float *rgb);
/* Makes the source of the body from the light that it gets, on this thread. No other thread may shade a scene
   that has the source meanwhile, since the same field is rewritten.
   rgb      results of sfield_shade for the points, 3 floats each; what is negative or not finite counts as
            0, what is above 1e18 as 1e18
   Errors   SFIELD_ERR_ARGUMENT (NULL)
   Cost     for each patch about that of copying its part of the field */

SFIELD_DEF const sfield_field *sfield_bounce_source(const sfield_bounce *bounce);
/* Returns the source field, dark before the first sfield_bounce_update; NULL for NULL. It belongs to the
   bounce: do not free it. The pointer stays the same. Call sfield_scene_entities after each update, so that
   caches notice. */
#endif
