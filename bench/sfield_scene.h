/* sfield_scene.h - what the benchmarks of shadowfield.h share: points on meshes, and rays through scenes as
   they stand. */
#ifndef BN_SFIELD_SCENE_H
#define BN_SFIELD_SCENE_H

#include "bench.h"
#include "scene.h"
#include "shadowfield.h"

typedef struct bn_points { float *positions, *normals; size_t count; } bn_points;

/* `count` points spread evenly over a mesh, neighbours near each other, with the normals of their triangles. 0,
   or -1. */
int  bn_points_spread(bn_points *points, const ex_mesh *mesh, size_t count);
void bn_points_free(bn_points *points);

/* Point i of a mesh, and its normal, where an object stands (rotation and one scale). */
void bn_points_world(const bn_points *points, size_t i, const float transform[16], float p[3], float n[3]);

/* Direction i of n, spread evenly over the cap 1 - cosine <= cap about a unit axis. */
void bn_cap_direction(const float axis[3], float cap, int i, int n, float direction[3]);

typedef struct bn_error { double square, sum; size_t count; } bn_error;
void   bn_error_add(bn_error *error, double value, double truth);
double bn_error_relative(const bn_error *error);         /* RMSE by mean of the truth */

sfield_desc bn_sfield_desc(const bn_options *options);   /* with threads; else all defaults */
const char *bn_sfield_simd(void);

#endif
