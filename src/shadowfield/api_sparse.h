/* ---- sparse vertices: shade few, interpolate the rest ---- */

SFIELD_DEF sfield_result sfield_sparse(const sfield_points *points, float spacing,
                                       const sfield_system *system, uint32_t *chosen, size_t *chosen_count,
                                       uint32_t *sources, float *weights);
/* Chooses the points of an object far from the eye that are worth shading: about one for each cube of edge
   `spacing` and side of the surface. Shade these alone, then call sfield_spread.
   points   count (1..2^31 - 1), positions and normals (any length) with their strides; the other members are
            not read
   spacing  world units, > 0
   system   NULL = malloc and free
   chosen   room for count numbers; *chosen_count numbers of points are written, cube by cube
   sources  for each point the places of 3 points in `chosen`
   weights  for each point the 3 weights of these; their sum is 1
   Errors   SFIELD_ERR_ARGUMENT (a pointer is NULL, there are no points, or a stride or spacing is out of
            range), SFIELD_ERR_INPUT (a point that is not finite, or farther than 1e9 spacings from the
            origin), SFIELD_ERR_LIMIT (2^31 points), SFIELD_ERR_DESC (allocator), SFIELD_ERR_ALLOC
   Cost     O(count log count), 40 bytes a point */

SFIELD_DEF sfield_result sfield_spread(size_t count, const uint32_t *sources, const float *weights,
                                       size_t chosen_count, const float *rgb, float *out);
/* Interpolates shaded points for all others: out[i] is the sum of the rgb of the three sources of point i,
   times their weights.
   sources, weights   as sfield_sparse writes them, for count points
   rgb      3 floats for each of the chosen_count points that were shaded
   out      3 floats for each of count points; not rgb
   Errors   SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_INPUT (a source is not below
            chosen_count). There is no log */
