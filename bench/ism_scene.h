/* ism_scene.h - what the benchmarks of ism.h and of its GL path render. */
#ifndef BN_ISM_SCENE_H
#define BN_ISM_SCENE_H

#include "bench.h"
#include "../examples/render/ism_parts.h"

typedef struct bn_scene {        /* one scene, its picture, its lit surfaces */
    const char *name;
    ex_scene    scene;
    ex_gbuffer  gbuffer;
    rd_emitter *emitters;
    rd_job      job;
    im_rsms     rsms;
    im_mesh     mesh;
    ism_points    view;
    bn_rays    *rays;
    bn_model    flat;
    double      rsm_ms;
} bn_scene;

/* path: a file, or builtin:NAME; rsm: texels a side; light_points: RSMs of each area light. 0, or -1 after
   a message. */
int bn_ism_open(bn_scene *scene, const bn_options *options, const char *path, uint32_t width, uint32_t height,
                uint32_t rsm, uint32_t light_points);
void bn_ism_close(bn_scene *scene);
int  bn_ism_light(bn_scene *scene, const bn_options *options, uint32_t rsm, uint32_t light_points);  /* RSMs anew */

ism_desc    bn_ism_desc(const bn_options *options, uint32_t vpls, uint32_t surfels);   /* on the pool's threads */
ism_frame   bn_ism_frame(const bn_scene *scene);
const char *bn_ism_simd(void);       /* what ism.h takes at run time */

/* compare's relative_rmse and mean_ratio; the first of them without the hundredth of the pixels that are farthest off;
   and both over the pixels that are not among the brightest hundredth of the reference b. */
typedef struct bn_picture_error { double rmse, ratio, rmse_99, rmse_below, ratio_below; } bn_picture_error;
int bn_picture_error_of(const float *a, const float *b, size_t pixels, bn_picture_error *out);    /* -1: no memory */
void bn_picture_error_print(const bn_picture_error *e);         /* as fields of a row, beside the reference */

#endif
