/* ---- lights, point by point, and where maps of them look from ---- */

typedef struct lsamp_emission {     /* one point of a light as seen from a point p */
    float direction[3];             /* unit, from p to the point of the light */
    float distance;                 /* from p to the point of the light; LSAMP_INFINITY for environment and
                                       sun */
    float coords[3];                /* the light's own coordinates of the point, in [0, 1); 0 for those that
                                       this kind of light does not have */
    float radiance[3];              /* from the light towards p, W/(sr m^2); of sun, point and spot the
                                       irradiance of a surface at p that faces the light, W/m^2 */
    float pdf;                      /* the density, per solid angle as seen from p, with which
                                       lsamp_light_sample draws this direction; 1 for sun, point and spot,
                                       which have one direction only */
} lsamp_emission;

LSAMP_DEF int lsamp_light_sample(const lsamp_light *light, const float p[3], const float u[3],
                                 lsamp_emission *out);
/* Draws a point of the light from the density P_L: in proportion to the texels (linear ones: to the mean over
   each), or, of rectangles and spheres without texels, evenly over the solid angle seen from p. Returns 1;
   returns 0 and leaves *out untouched if no light of the drawn point reaches p, or if an argument is NULL or
   out of range.
   u        random numbers in [0, 1); u[2] serves callbacks and meshes only */

LSAMP_DEF int lsamp_light_hit(const lsamp_light *light, const float p[3], const float direction[3],
                              lsamp_emission *out);
/* Writes the point of the light at which a ray from p would arrive if nothing stood between them. Returns 1;
   returns 0 and leaves *out untouched if the ray misses the light, or if an argument is NULL or out of range.
   Sun, point and spot have no area to hit; a callback cannot be intersected; and meshes and surfaces are not
   searched: for these the function always returns 0, and lsamp_light_sample is the only way to reach them.
   direction  unit */

LSAMP_DEF size_t lsamp_light_triangles(const lsamp_light *light, float *corners);
/* Returns the number of pieces that a mesh was cut into, 0 for other kinds, and writes the pieces in the
   order of the mesh's curve. A piece is a triangle; the areas of pieces differ by at most a factor of two,
   but for triangles of the mesh that are smaller still.
   corners  receives 9 floats a piece, x, y, z of each corner; NULL: the pieces are only counted */

LSAMP_DEF lsamp_result lsamp_surface_locations(const lsamp_surface *surface, uint32_t width, uint32_t height,
                                               float lift, float *locations);
/* Writes D for a LSAMP_LIGHT_SURFACE: the surface at the centres of width x height equal cells of its
   coordinates, for a domain of LSAMP_DOMAIN_TABLE with these sides, whose maps are asked by the samples'
   coords, which lie 12 bytes apart (cohsm_query.light_stride): side is width, height, 1, and location_count
   width * height.
   lift        how far the places stand above the side that emits, in the scene's units, lest the surface
               itself hides all; below 0: behind it
   locations   receives 4 floats for each cell, rows of width: x, y, z, 1. Where the surface's points are not
               finite they are not finite either: put other ones there, since csm.h refuses such locations
   Errors      LSAMP_ERR_ARGUMENT (NULL, a side of 0), LSAMP_ERR_INPUT (surface->points is NULL, its width or
               height, lift). There is no log */

typedef enum lsamp_domain_kind {    /* the numbers are those of cohsm_domain_kind */
    LSAMP_DOMAIN_DEFAULT,           /* = LSAMP_DOMAIN_LATLONG, which lsamp_light_domain writes in its place */
    LSAMP_DOMAIN_LATLONG = 1,       /* directions: s = 0.5 + atan2(z, x) / 2 pi, t = acos(y) / pi */
    LSAMP_DOMAIN_LINE = 3,          /* positions: origin + s u */
    LSAMP_DOMAIN_RECTANGLE = 4,     /* positions: origin + s u + t v */
    LSAMP_DOMAIN_DISC = 5,          /* positions on a disc about origin; u and v are its two half axes */
    LSAMP_DOMAIN_SPHERE = 6,        /* positions on the sphere of radius |u| about origin; s turns about +Y,
                                       t runs with equal areas from +Y to -Y */
    LSAMP_DOMAIN_TABLE = 8,         /* positions: locations, asked by a parameter 0..1 */
    LSAMP_DOMAIN_LIST = 9,          /* positions: locations, asked by index */
    LSAMP_DOMAIN_COUNT
} lsamp_domain_kind;

typedef struct lsamp_domain {       /* has the fields of cohsm_domain (csm.h): copy them one by one into
                                       cohsm_desc.domain */
    lsamp_domain_kind kind;
    uint32_t side[3];               /* cells along each dimension; 0 = you choose */
    float origin[3], u[3], v[3], w[3];
    const float *locations;         /* TABLE, LIST: x, y, z, 1 each */
    size_t location_count;
} lsamp_domain;

LSAMP_DEF lsamp_result lsamp_light_domain(const lsamp_light *light, lsamp_domain *out);
/* Writes D of section 4: the directions or positions for which visibility maps, such as csm.h's, must be made
   so that they answer for samples of this light. Ask maps of a sky or a sun (LATLONG) with the samples'
   directions, maps of a point or a spot (LIST) with index 0, and all others with the samples' coords, three
   floats each (csm.h: COHSM_LIGHT_PARAMETER, light_stride 12).
   out      side is 0, which csm.h takes for its default, except for the TABLE of a mesh; the locations of
            LIST and TABLE lie in the light's memory
   Errors   LSAMP_ERR_ARGUMENT (NULL), LSAMP_ERR_MISMATCH (a callback or a surface: make a table of
            positions from shape_fn, or by lsamp_surface_locations) */

/* ---- materials, direction by direction ---- */

LSAMP_DEF lsamp_result lsamp_brdf_eval(const lsamp_material *material, const float normal[3],
                                       const float tangent[3], const float to_eye[3],
                                       const float direction[3], float f[3], float *pdf);
/* Writes f(wo, wi), the BRDF in 1/sr without the cosine, for wo = to_eye and wi = direction, and the density
   per solid angle with which lsamp_brdf_sample draws the direction.
   tangent    unit; made orthogonal to normal. NULL = any direction
   to_eye     unit, away from the surface; below it, it is lifted to just above
   direction  unit, away from the surface; f is 0 if it points below
   f          receives red, green, blue
   Errors   LSAMP_ERR_ARGUMENT (NULL), LSAMP_ERR_INPUT (a vector that is not unit, material). There is no log,
            for this is called for each direction: lsamp_sample's log names what is wrong with a material */

LSAMP_DEF lsamp_result lsamp_brdf_sample(const lsamp_material *material, const float normal[3],
                                         const float tangent[3], const float to_eye[3], const float u[2],
                                         float direction[3], float f[3], float *pdf);
/* Draws a direction from the material's density P_f, and writes f and the density as lsamp_brdf_eval does. A
   *pdf of 0 says that there is no sample, because the drawn direction points below the surface or the
   material is black; the direction is the normal then.
   u        random numbers in [0, 1): u[0] chooses the lobe by Russian roulette and is then stretched to 0..1
            again
   Errors   those of lsamp_brdf_eval; LSAMP_ERR_INPUT also for u. There is no log */
