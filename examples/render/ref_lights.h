/* ref_lights.h - the lights of the reference path tracer: sampling, densities, and what a ray sees of them.
   Explicit lights are no geometry: rays pass through them and they cast no shadow. */
#ifndef RF_LIGHTS_H
#define RF_LIGHTS_H

#include "technique.h"
#include "ref_math.h"

/* A cumulative distribution; guide[k] is the interval at k / count of the whole, so that a search takes O(1). */
typedef struct rf_table { double *cdf; uint32_t *guide; size_t count; } rf_table;

typedef struct rf_lights {
    const ex_scene   *scene;
    const rd_emitter *emitters;
    rf_table          emitter_table;   /* by area times mean radiance */
    double            emitter_power;   /* the sum of it */
    rf_table          rows;            /* of the sky, by their share of sky_power */
    rf_table         *texels;          /* one table a row */
    double            sky_power;       /* integral of mean radiance over the sphere */
    double            sky_cos, sky_sin;
    double            epsilon;         /* length of offsets */
    size_t            source_count;    /* scene->light_count + 2: lights, emitters, sky */
    rf_table          pick[2];         /* choice of a source; [1] without sun, spot and point lights */
    uint64_t          bytes;
} rf_lights;

typedef struct rf_light_sample {
    rf_v3  target;             /* end of the shadow ray, when it has one */
    rf_v3  direction;          /* unit, towards the light */
    int    at_infinity;
    int    is_delta;           /* sun, spot, point: no other way to find it */
    rf_v3  value;              /* radiance; of delta lights, irradiance across the direction */
    double pdf;                /* per solid angle, choice of the source included; of delta lights the choice alone */
} rf_light_sample;

int  rf_lights_init(rf_lights *lights, const rd_job *job, double epsilon, char *error);
void rf_lights_free(rf_lights *lights);

/* One sample of a light that can reach p. area_only: no delta lights. 0: nothing. */
int  rf_lights_sample(const rf_lights *lights, rf_v3 p, int area_only, const double u[2], rf_light_sample *sample);
/* Light scene->lights[index] if it is a sun, spot or point that reaches p; its pdf is 1. 0: it is not. */
int  rf_lights_delta(const rf_lights *lights, uint32_t index, rf_v3 p, rf_light_sample *sample);

/* What a ray meets, each with the density that rf_lights_sample has for that direction. */
int    rf_lights_hit(const rf_lights *lights, uint32_t index, int area_only, rf_v3 origin, rf_v3 direction,
                     double limit, rf_v3 *radiance, double *pdf);          /* explicit area light nearer than limit */
double rf_lights_emitter_pdf(const rf_lights *lights, int area_only, rf_v3 radiance, double distance, double cosine);
rf_v3  rf_lights_sky(const rf_lights *lights, int area_only, rf_v3 direction, double *pdf);

#endif
