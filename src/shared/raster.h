/* unit raster: the fill rule of rasterisers: triangles that share an edge leave no gap and do not overlap */

/* Returns 1 if points on an edge belong to the triangle whose edge this is, of the two that share it. The
   triangle lies on the side where dx (y - y0) - dy (x - x0) is positive; its left edges own their points,
   and its top edges if y grows downwards. Exactly one of two opposite edges owns. */
static inline int P_edge_owns(double dx, double dy) { return dy < 0.0 || (dy <= 0.0 && dx > 0.0); }
