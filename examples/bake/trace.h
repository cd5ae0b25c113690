/* trace.h - light that arrives at a point, by paths: the lights and the scene of render's reference, so that what is
   baked is what its pictures show, with Lambert's surfaces. */
#ifndef BAKE_TRACE_H
#define BAKE_TRACE_H

#include "bake.h"
#include "../render/ref_lights.h"
#include "../render/ref_scene.h"

typedef struct bk_trace {
    rf_scene   *scene;
    rf_lights   lights;
    rd_emitter *emitters;
    double      epsilon;
    int         bounces;
    float       center[3], radius;
} bk_trace;

/* Adds --env and --light to the scene, a sky where nothing shines, and opens it. 0, or -1 with one line in error. */
int  bk_trace_open(bk_trace *trace, const bk_args *args, ex_scene *scene, char *error);
void bk_trace_close(bk_trace *trace);

/* Light from a direction: the sum of what `take` is given over all samples is the integral of radiance times whatever
   depends on the direction. */
typedef void (*bk_take_light)(void *user, rf_v3 direction, rf_v3 light);

/* Samples of what arrives at a point, from the hemisphere about its normal or, if that is 0, from everywhere. The
   random numbers follow from `seed` alone. */
void bk_trace_light(const bk_trace *trace, rf_v3 point, rf_v3 normal, uint32_t samples, uint64_t seed,
                    bk_take_light take, void *user);
double bk_random(uint64_t *state);                   /* in 0..1 */

#endif
