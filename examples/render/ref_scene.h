/* ref_scene.h - the scene of the reference path tracer: all objects in world space inside Embree 3 or 4. */
#ifndef RF_SCENE_H
#define RF_SCENE_H

#include "technique.h"
#include "ref_math.h"

typedef struct rf_scene rf_scene;

typedef struct rf_hit {
    double   distance;
    rf_v3    position;
    rf_v3    geometric;        /* unit, faces the origin of the ray */
    rf_v3    normal;           /* shading normal, on the same side of the surface as geometric */
    rf_v3    base;             /* base colour times texture */
    rf_v3    emission;         /* towards the origin of the ray */
    double   metallic, roughness;
} rf_hit;

const char *rf_scene_version(void);            /* "Embree 3.13.5"; NULL where this build has none */
rf_scene *rf_scene_create(const ex_scene *scene, int threads, char *error);
void      rf_scene_free(rf_scene *scene);
void      rf_scene_memory(const rf_scene *scene, uint64_t *now, uint64_t *peak);       /* as Embree counts it */

int rf_scene_trace(const rf_scene *scene, rf_v3 origin, rf_v3 direction, double near_distance, rf_hit *hit);
int rf_scene_blocked(const rf_scene *scene, rf_v3 origin, rf_v3 direction, double length);     /* HUGE_VAL: infinite */

#endif
