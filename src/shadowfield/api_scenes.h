/* ---- scenes ---- */

typedef enum sfield_product_mode {
    SFIELD_PRODUCT_DEFAULT,         /* = TRIPLE for harmonics, TEXELS for wavelets */
    SFIELD_PRODUCT_TRIPLE,          /* harmonics: projected after every product */
    SFIELD_PRODUCT_EXP,             /* harmonics: one exp of the sum of logarithms for each light; needs
                                       fields of them */
    SFIELD_PRODUCT_TEXELS,          /* wavelets: expanded where they have detail, multiplied on texels */
    SFIELD_PRODUCT_SPARSE,          /* wavelets: sublinear product of coefficients (the paper). Rotated
                                       entities may only receive, without a self-visibility */
    SFIELD_PRODUCT_COUNT
} sfield_product_mode;

typedef struct sfield_scene_desc {
    sfield_system       system;
    sfield_basis        basis;
    uint32_t            bands;          /* harmonics: 1..8; 0 = 4. Fields must have as many */
    uint32_t            cube_side;      /* wavelets: as the fields; 0 = 32. Harmonics: of the environment; 0 =
                                           16 */
    sfield_product_mode product;
    float               reach;          /* occluders count up to this many r and fade over the last quarter
                                           (the paper's third culling rule); 0 = the outermost shell of the
                                           field */
    int                 strict;         /* not 0: a light whose bounding sphere overlaps that of an object is
                                           an error */
} sfield_scene_desc;

typedef struct sfield_scene_stats {
    uint64_t points;                /* that were shaded, those left out by `visible` not among them */
    uint64_t pairs;                 /* of a point and an occluder that is not its own */
    uint64_t culled_far, culled_horizon, culled_hidden;   /* pairs left out by each of the three rules */
    uint64_t products;              /* of a point's T with an occluder */
    uint64_t lights;                /* dot products of a point with a light */
    uint64_t reused;                /* of them, with a T from the cache */
    uint32_t overlaps;              /* pairs of a light and an object whose bounding spheres overlap */
} sfield_scene_stats;

/* sfield_scene_create: errors SFIELD_ERR_DESC, SFIELD_ERR_ARGUMENT, SFIELD_ERR_ALLOC.

   sfield_scene_entities copies where everything is now, at most 65535 entities. Call it for each frame in
   which something moved. Where it fails the scene keeps what it had.
   Errors  SFIELD_ERR_ARGUMENT, SFIELD_ERR_INPUT (a transform that is not a rotation with one scale and a
           translation, a tint that is not finite; strict: an overlap), SFIELD_ERR_MISMATCH (basis, bands,
           cube, kind, a shard; SPARSE: a rotated entity that hides or shines), SFIELD_ERR_LIMIT,
           SFIELD_ERR_ALLOC

   sfield_scene_environment takes distant light as a latitude-longitude map of radiance; it is copied.
   rgb       width x height x 3, from +Y down: the centre is +X, and +Z is right of it; NULL = no environment.
             Texels that are negative or not finite count as 0; each has one radiance, and its exact solid
             angle
   rotation  map to world, NULL or 0 = none. Errors SFIELD_ERR_ARGUMENT, SFIELD_ERR_INPUT (rotation),
             SFIELD_ERR_ALLOC

   sfield_shade computes the direct light at all points of all sets, from near to far (figure 5 of the paper).
   Results are not clamped: ringing may go below 0, and surfaces that face a sun are 25 % too dark with 2
   bands, 6 % too bright with 3 or 4.
   Errors  SFIELD_ERR_ARGUMENT (NULL, a stride, an entity beyond the list, exponents without views),
           SFIELD_ERR_INPUT (a normal or view that is not unit), SFIELD_ERR_MISMATCH (self or cache of another
           basis or count, gloss in wavelets, self on a rotated entity with SPARSE), SFIELD_ERR_ALLOC. Points
           that are not finite get 0
   Cost    harmonics: about 0.1 us for a point and an occluder in reach */

SFIELD_DEF sfield_result sfield_scene_turn(sfield_scene *scene, const float rotation[16]);
/* Gives the same environment another rotation, for the price of one rotation of coefficients, or of one cube
   map. */
SFIELD_DEF sfield_result sfield_scene_sun(sfield_scene *scene, const float direction[3],
                                          const float irradiance[3]);
/* Adds a direction of light to the environment, until sfield_scene_environment is called again;
   sfield_scene_turn does not turn it. direction is unit; NULL takes all suns away: set what moved anew, and
   the map stays. Errors SFIELD_ERR_ARGUMENT, SFIELD_ERR_INPUT */

SFIELD_DEF sfield_result sfield_scene_sky(const sfield_scene *scene, float *coefs);
/* Writes environment and suns as they are now, for shaders: bands^2 coefficients of r, then of g, then of b.
   Harmonics only: else SFIELD_ERR_MISMATCH. SFIELD_ERR_ARGUMENT: NULL */

SFIELD_DEF sfield_result sfield_cache_create(const sfield_scene *scene, size_t point_count,
                                             uint32_t light_count, sfield_cache **out);
/* Makes room for T of a set of points for light_count lights of this scene, of which the environment is one:
   lazy occlusion updating. It takes 4 n^2 bytes a point and light with harmonics, 4 bytes a wavelet kept,
   from the scene's allocator, and is filled with the first frame. Entities that move or change, another
   scene, `entity` or `self` are noticed; positions and normals that you rewrite (a mesh that deforms, another
   level of detail) are not: free the cache and create another. Errors SFIELD_ERR_ARGUMENT,
   SFIELD_ERR_ALLOC */
SFIELD_DEF void sfield_cache_free(sfield_cache *cache);      /* accepts NULL */
SFIELD_DEF size_t sfield_cache_bytes(const sfield_cache *cache);
/* Returns how much memory a cache holds; 0 for NULL. */

SFIELD_DEF sfield_result sfield_incident(sfield_scene *scene, const sfield_points *set, float *coefs);
/* Computes the incident radiance instead, from far to near, with occluders that several lights have in common
   applied once (section 3.2 of the paper). Harmonics only.
   coefs   3 n^2 floats a point, in world space, without self-visibility and BRDF: of all directions, whatever
           the normal, which must be there all the same. Errors as sfield_shade */

/* ---- sparse vertices: shade few, interpolate the rest ---- */

SFIELD_DEF sfield_result sfield_sparse(const sfield_points *points, float spacing,
                                       const sfield_system *system, uint32_t *chosen, size_t *chosen_count,
                                       uint32_t *sources, float *weights);
/* Chooses, for an object far from the eye, about one point for each cube of edge `spacing` and side of the
   surface.
   points   count, positions and normals (any length) with their strides; the other members are not read
   chosen   has room for count; the *chosen_count points to shade, in order
   sources  3 numbers into chosen for each point, weights: 3 floats, whose sum is 1
   Errors   SFIELD_ERR_ARGUMENT, SFIELD_ERR_INPUT, SFIELD_ERR_DESC (allocator), SFIELD_ERR_ALLOC.
   Cost     O(count log count) */
SFIELD_DEF sfield_result sfield_spread(size_t count, const uint32_t *sources, const float *weights,
                                       size_t chosen_count, const float *rgb, float *out);
/* Writes out[i], the sum of weights x rgb of the sources of point i. Errors SFIELD_ERR_ARGUMENT,
   SFIELD_ERR_INPUT (a source out of range). */
