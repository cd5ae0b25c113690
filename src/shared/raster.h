/* unit raster: the fill rule of rasterisers, so that triangles which share an edge leave no gap and no overlap */

/* A point on an edge belongs to the triangle whose edge this is, of the two that share it. The triangle lies where
   dx (y - y0) - dy (x - x0) is positive: then these are its left edges, and its top edges where y grows downwards.
   Exactly one of two opposite edges owns. */
static inline int P_edge_owns(double dx, double dy) { return dy < 0.0 || (dy <= 0.0 && dx > 0.0); }
