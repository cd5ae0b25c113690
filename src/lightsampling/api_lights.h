/* ---- lights, point by point, and where maps of them look from ---- */

typedef struct lsamp_emission {     /* one point of a light as seen from a point p */
    float direction[3];             /* unit, from p to it */
    float distance;                 /* LSAMP_INFINITY for environment and sun */
    float coords[3];                /* in [0, 1), the light's own coordinates; unused ones are 0 */
    float radiance[3];              /* towards p; sun, point, spot: irradiance of a surface that faces them */
    float pdf;                      /* with which lsamp_light_sample returns it, per solid angle; sun, point,
                                       spot: 1 */
} lsamp_emission;

LSAMP_DEF int lsamp_light_sample(const lsamp_light *light, const float p[3], const float u[3],
                                 lsamp_emission *out);
/* Picks a point of the light from its density P_L: in proportion to its texture; of rectangles and spheres
   without one by solid angle. Returns 0, *out untouched, where nothing reaches p.
   u        random numbers in [0, 1); u[2] serves callbacks only */

LSAMP_DEF int lsamp_light_hit(const lsamp_light *light, const float p[3], const float direction[3],
                              lsamp_emission *out);
/* Finds what a ray from p sees of the light alone. Returns 0, *out untouched, if it misses. That is always
   so for sun, point, spot and callback, which have no area or none that is known, and for meshes, whose
   triangles a ray would have to search: those are only sampled from their side. */

LSAMP_DEF size_t lsamp_light_triangles(const lsamp_light *light, float *corners);
/* Returns the number of pieces of a mesh, 0 for other shapes, and writes them in the order of the mesh's
   curve. They are equal in area within a factor of two unless triangles are smaller.
   corners  9 floats each; NULL: they are only counted */

typedef enum lsamp_domain_kind {    /* the numbers are those of cohsm_domain_kind */
    LSAMP_DOMAIN_DEFAULT,           /* never written */
    LSAMP_DOMAIN_LATLONG = 1,       /* directions: s = 0.5 + atan2(z, x) / 2 pi, t = acos(y) / pi */
    LSAMP_DOMAIN_LINE = 3,          /* positions: origin + s u */
    LSAMP_DOMAIN_RECTANGLE = 4,     /* positions: origin + s u + t v */
    LSAMP_DOMAIN_DISC = 5,          /* positions on a disc about origin; u and v are its two half axes */
    LSAMP_DOMAIN_SPHERE = 6,        /* positions on the sphere of radius |u| about origin, latitude-longitude
                                       of equal area */
    LSAMP_DOMAIN_TABLE = 8,         /* positions: locations, asked by a parameter 0..1 */
    LSAMP_DOMAIN_LIST = 9,          /* positions: locations, asked by index */
    LSAMP_DOMAIN_KIND_COUNT
} lsamp_domain_kind;

typedef struct lsamp_domain {       /* fields as in cohsm_domain: copy them one by one into
                                       cohsm_desc.domain */
    lsamp_domain_kind kind;
    uint32_t side[3];               /* cells along each dimension; 0 = you choose */
    float origin[3], u[3], v[3], w[3];
    const float *locations;         /* TABLE, LIST: x, y, z, 1 each */
    size_t location_count;
} lsamp_domain;

LSAMP_DEF lsamp_result lsamp_light_domain(const lsamp_light *light, lsamp_domain *out);
/* Writes D of section 4: the directions or positions for which visibility maps, such as csm.h's, must be
   made so that they answer for samples of this light. Those maps are asked with the samples' coords, three
   floats each (csm.h: COHSM_LIGHT_PARAMETER, light_stride 12); the sky's and the sun's, LATLONG, with
   directions; a point's and a spot's, LIST, by index 0.
   out      its side is 0, the default, but for a mesh's TABLE; locations of LIST and TABLE point into the
            light
   Errors   LSAMP_ERR_ARGUMENT, also for callbacks, which have no domain: make a table of positions from
            shape_fn */

/* ---- materials, direction by direction ---- */

LSAMP_DEF lsamp_result lsamp_brdf_eval(const lsamp_material *material, const float normal[3],
                                       const float tangent[3], const float wo[3], const float wi[3],
                                       float f[3], float *pdf);
/* Writes f(wo, wi), the BRDF in 1/sr without the cosine, and the density per solid angle with which
   lsamp_brdf_sample returns wi.
   tangent  NULL: any; else unit, and made orthogonal to normal
   wo, wi   unit, away from the surface; f is 0 where wi is below it, and wo is lifted to just above it
   Errors   LSAMP_ERR_ARGUMENT (NULL, NaN, length), LSAMP_ERR_DESC (material) */

LSAMP_DEF lsamp_result lsamp_brdf_sample(const lsamp_material *material, const float normal[3],
                                         const float tangent[3], const float wo[3], const float u[2],
                                         float wi[3], float f[3], float *pdf);
/* Picks a direction wi from the material's density P_f, and writes f and the density as lsamp_brdf_eval
   does. A *pdf of 0 says that there is no sample, since the lobe went below the surface or the material is
   black; wi is the normal then.
   u        random numbers, 0 <= u < 1: u[0] picks the lobe by Russian roulette and is then stretched to 0..1
            again
   Errors   those of lsamp_brdf_eval */
