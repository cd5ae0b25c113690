/* ---- scenes ---- */

typedef enum sfield_product_mode {  /* how the visibilities of several entities are multiplied */
    SFIELD_PRODUCT_DEFAULT,         /* = TRIPLE for harmonics, TEXELS for wavelets */
    SFIELD_PRODUCT_TRIPLE,          /* harmonics: every product is projected on the same bands again */
    SFIELD_PRODUCT_EXP,             /* harmonics: logarithms are added, and the sum's exponential is taken
                                       once for each light. The fields must have been built with
                                       desc.logarithm */
    SFIELD_PRODUCT_TEXELS,          /* wavelets: expanded where they have detail, multiplied on texels */
    SFIELD_PRODUCT_SPARSE,          /* wavelets: the paper's sublinear product of coefficients. Rotated
                                       entities may receive light, but neither hide nor shine, nor have a
                                       self-visibility */
    SFIELD_PRODUCT_COUNT
} sfield_product_mode;

typedef struct sfield_scene_desc {  /* zero it, then set what you care about */
    sfield_system       system;         /* kept: the scene's later calls use it too */
    sfield_basis        basis;          /* of all fields of the scene */
    uint32_t            bands;          /* of harmonics, 1..8; 0 = 4. Fields must have as many */
    uint32_t            cube_side;      /* texels a side of a cube's face, a power of two, 4..64. Wavelets: as
                                           the fields have; 0 = 32. Harmonics: of the environment; 0 = 16 */
    sfield_product_mode product;
    float               reach;          /* occluders count up to this many radii of their bounding sphere,
                                           0..1e6, and fade over the last quarter of that way (the paper's
                                           third culling rule); 0 = the outermost shell of each field */
    int                 strict;         /* not 0: sfield_scene_entities fails if the bounding sphere of a
                                           light overlaps that of an object */
} sfield_scene_desc;

typedef struct sfield_scene_stats { /* what sfield_shade counted */
    uint64_t points;                /* points that were shaded; those left out by `in_view` do not count */
    uint64_t pairs;                 /* pairs of a point and an occluder on which the point does not lie */
    uint64_t culled_far;            /* pairs left out because the occluder is out of reach */
    uint64_t culled_horizon;        /* pairs left out because the occluder lies below the point's horizon */
    uint64_t culled_hidden;         /* pairs left out because nearer occluders hide this one */
    uint64_t products;              /* multiplications of a point's T by the visibility of an occluder */
    uint64_t lights;                /* dot products of a point's T with a light */
    uint64_t reused;                /* those of `lights` whose T came from the cache */
    uint32_t overlaps;              /* pairs of a light and an object whose bounding spheres overlap */
    uint32_t rooms;                 /* those of them whose light lies in the object's convex hull, by its
                                       field: the object is taken for a convex room, which hides the light
                                       from no point in the hull, and may from all others. In a hollow that is
                                       not convex light goes through corners. Objects whose fields hold
                                       logarithms are no rooms, and there are none where `overlaps` is above
                                       65,536 */
} sfield_scene_stats;

SFIELD_DEF sfield_result sfield_scene_turn(sfield_scene *scene, const float to_world[16]);
/* Gives the same environment another rotation, from the map's space to the world; all 0 = none. It costs the
   rotation of 3 vectors of coefficients, or of one cube map.
   Errors   SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_INPUT (not a rotation) */

SFIELD_DEF sfield_result sfield_scene_sun(sfield_scene *scene, const float direction[3],
                                          const float irradiance[3]);
/* Adds a sun, light from one direction, to the environment. sfield_scene_turn does not turn suns. To move a
   sun take all of them away and add them anew; the map stays.
   direction    unit, towards the sun, in the world; NULL takes all suns away
   irradiance   r, g, b of a surface that faces the sun, 0..1e18 W/m^2
   Errors   SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_INPUT (a vector that is not unit, irradiance) */

#ifndef SFIELD_WITHOUT_TABLES
SFIELD_DEF sfield_result sfield_scene_sky(const sfield_scene *scene, float *coefs);
/* Writes the environment and its suns as they are now, for shaders: bands^2 coefficients of r, then of g,
   then of b; of a scene of wavelets 6 cube_side^2 texels of each.
   Errors   SFIELD_ERR_ARGUMENT (NULL) */
#endif

#ifndef SFIELD_WITHOUT_CACHE
SFIELD_DEF sfield_result sfield_cache_create(const sfield_scene *scene, size_t point_count,
                                             uint32_t light_count, sfield_cache **out);
/* Makes room in which a set of points keeps, from frame to frame, its T for each light: lazy occlusion
   updating (section 4.2). The next sfield_shade fills the cache; then only what has changed is computed anew:
   T of a point and a light is kept until an occluder between the two moves, comes or goes, or the entity that
   the point lies on moves. A light that moves keeps its T as long as it passes no occluder. Points get the
   results of the frame before, at the cost of a copy, if only occluders out of their reach moved since. The
   cache notices all that by itself, and another scene, `entity` or `self` of the set.
   With gloss the T of all kernels is kept, until to_eye, exponents or materials change: what stands before a
   moving eye is computed anew. Give what is diffuse a set of its own if the eye moves and little else does.
   It does not notice positions and normals that you rewrite (a mesh that deforms, another level of detail):
   then free the cache and create another.
   point_count   of the set, 1..2^31 - 1
   light_count   1..65536 lights of the scene, of which the environment is one. Lights beyond keep nothing
   Memory   from the scene's allocator: with harmonics 4 bands^2 + 9 bytes for each point and light, and 19
            for each point; with wavelets, of which the 256 largest are kept, 1,036 bytes for each point and
            light, and 76 for each point. The first sfield_shade with exponents (materials) takes twice (three
            times) as much instead, and 24 bytes more for each point
   Errors   SFIELD_ERR_ARGUMENT (scene, which leaves no log, or out is NULL; a count is out of range),
            SFIELD_ERR_ALLOC (also if the bytes overflow a size_t) */

SFIELD_DEF void sfield_cache_free(sfield_cache *cache);
/* Takes back a cache and its memory. Accepts NULL. */

SFIELD_DEF size_t sfield_cache_bytes(const sfield_cache *cache);
/* Returns how much memory a cache holds; 0 for NULL. */
#endif

#ifndef SFIELD_WITHOUT_INCIDENT
SFIELD_DEF sfield_result sfield_incident(sfield_scene *scene, const sfield_points *set, float *coefs);
/* Computes the radiance that arrives at points, as coefficients, for materials of your own. Entities are
   taken from far to near, so that occluders which several lights have in common are applied once (section
   3.2); those of a light that lies in a room (sfield_scene_stats.rooms) for it alone.
   set      the arrays for results are not written; normals must be there, but all directions count, whatever
            the normal. Self-visibility and BRDF are not applied
   coefs    bands^2 coefficients of r, then of g, then of b for each point, in world space
   Errors   as sfield_shade; SFIELD_ERR_MISMATCH also for wavelets and SFIELD_PRODUCT_EXP */
#endif
