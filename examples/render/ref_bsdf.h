/* ref_bsdf.h - reflection in the reference path tracer.

   materials=diffuse: Lambert, base colour / pi.
   materials=full: glTF 2.0's metal-rough model (its appendix B): with alpha = max(roughness^2, 0.002),
   F0 = mix(0.04, base, metallic) and Schlick's F at view . half,
       f = (1 - F) base (1 - metallic) / pi + F D(GGX) V(Smith, height-correlated) */
#ifndef RF_BSDF_H
#define RF_BSDF_H

#include "ref_math.h"

typedef struct rf_bsdf {
    rf_v3  normal, x, y;       /* shading frame */
    rf_v3  view;               /* unit, in that frame, z > 0 */
    rf_v3  diffuse, f0;
    double alpha;              /* 0: no specular lobe */
    double specular_share;     /* of sampled directions that follow the specular lobe */
} rf_bsdf;

/* normal and view have unit length; a view from below the shading normal's horizon is lifted just above it. */
void   rf_bsdf_init(rf_bsdf *bsdf, rf_v3 normal, rf_v3 view, rf_v3 base, double metallic, double roughness, int full);
/* f times the cosine towards direction; pdf: what rf_bsdf_sample has for it, per solid angle. */
rf_v3  rf_bsdf_eval(const rf_bsdf *bsdf, rf_v3 direction, double *pdf);
/* 0 when the sample is lost; else *value is f cos / pdf. */
int    rf_bsdf_sample(const rf_bsdf *bsdf, const double u[2], rf_v3 *direction, rf_v3 *value, double *pdf);

#endif
