/* ---- bounced light ---- */

typedef enum rsm_pattern {          /* which texels a receiver takes its light from, if not from all */
    RSM_PATTERN_DEFAULT,            /* = RSM_PATTERN_FLUX */
    RSM_PATTERN_FLUX,               /* texels chosen in proportion to their flux, the same for all
                                       receivers */
    RSM_PATTERN_EQUATION3,          /* the paper's pattern about the receiver's projection, of density 1/r */
    RSM_PATTERN_LOG_RADIAL,         /* about the projection, of density 1/r^2 beyond r_min and even inside */
    RSM_PATTERN_POISSON,            /* about the projection, of even density over a disc, with a least
                                       distance between samples; 4096 samples at most */
    RSM_PATTERN_LOW_DISCREPANCY,    /* about the projection, of even density over a disc, by a
                                       (0, 2)-sequence */
    RSM_PATTERN_MIXED,              /* two fifths of the samples as in FLUX, three fifths as in LOG_RADIAL
                                       with r_min 1/192, put together by multiple importance sampling: the
                                       least error in corners, but slower. r_max and r_min are not used */
    RSM_PATTERN_COUNT
} rsm_pattern;

typedef struct rsm_material {       /* a Phong lobe that texels have beside their diffuse flux: the share of
                                       the incident light that it reflects is `specular` at most */
    float specular[3];              /* r, g, b, 0..1 */
    float exponent;                 /* 0..1e4 */
} rsm_material;

typedef void (*rsm_visible_fn)(void *user, const float position[3], const float normal[3],
                               const uint32_t *numbers, size_t count, float *visible);
/* A function of yours that writes how much of each light a receiver sees. ism.h and csm.h have functions of
   this type, ism_see and cohsm_see, which answer from their maps. Several threads of parallel_for may call
   the function at once.
   normal    that of rsm_points
   numbers   which lights are asked for: in rsm_gather_list their numbers in the list; in rsm_gather and
             rsm_interpolate their numbers in the list that rsm_pixel_lights writes for the same maps,
             sample_count and seed. Only lights that could light the receiver are asked for
   count     1..64
   visible   count floats: 0 = hidden, 1 = seen; more counts as 1, less and NaN as 0 */

typedef struct rsm_gather_desc {    /* zero it, then set what you care about */
    rsm_system  system;             /* without a log, as without a desc, the first map's is told */
    rsm_pattern pattern;
    uint32_t    sample_count;       /* texels that each receiver takes of each map, 1..2^20; 0 = every texel,
                                       whatever the pattern */
    int         paper_weights;      /* of EQUATION3; not 0: samples have the paper's weights, xi^2 normalised,
                                       which are biased; 0: each has the area that it stands for */
    float       r_max;              /* radius of patterns about the receiver, in sides of the map, 0..1000;
                                       of cubes the sine of half the angle (1 = all round). Above 0: samples
                                       outside the map count as dark, and light beyond r_max is lost. 0: each
                                       ray of the pattern ends at the map's border */
    float       r_min;              /* of LOG_RADIAL: the radius of its even disc, as a share of the
                                       pattern's, 0 or more, below 1; 0 = 1/32 */
    float       offset;             /* world units by which pixel lights move below their surface, 0..1e9
                                       (section 3.2) */
    float       clamp;              /* bound on cos cos / d^2, 1 / unit^2, up to 1e18; 0 = none */
    float       near_limit;         /* bound on the irradiance that one light gives, in units of its own
                                       radiosity (an infinite wall gives 1), up to 1e6; 0 = none. Texels
                                       without an area are not bounded */
    float       near_field;         /* 0 = all texels are points. Above 0, at most 32: a texel that is nearer
                                       to the receiver than near_field times its side (the root of its area)
                                       lights it as the parallelogram of surface that the texel is, by the
                                       exact form factor. 3 leaves no bright spots in corners. Works with
                                       sample_count 0 and with patterns about the receiver; lights chosen by
                                       flux and lists stay points. offset moves these texels, near_limit and
                                       clamp bound them like points; their Phong lobes are evaluated at their
                                       centre */
    uint32_t    seed;               /* chooses between equally good sets of samples. If gifilter.h takes the
                                       mean of several frames, count the seed up with each frame */
    const float *noise;             /* noise_side^2 floats in 0..1, tiled over the picture, by which each
                                       pixel's pattern is turned (but FLUX). rsm_blue_noise makes such. NULL =
                                       all patterns stand alike */
    uint32_t    noise_side;         /* 1..4096 */
    uint32_t    interleave;         /* k = 1, 2, 4, 8; 0 = 1. Above 1 the samples are dealt out to k x k sets,
                                       and pixel (x, y) takes set x % k + k (y % k) alone: k^2 times faster,
                                       and a grid of noise, which gifilter.h with log2 k passes smooths.
                                       Pictures alone have pixels (points->width) */
    const rsm_material *materials;  /* Phong lobes: texels with material m have materials[m - 1]. NULL: all
                                       texels are diffuse. FLUX chooses by diffuse flux, so that the lobes of
                                       black texels need sample_count 0 or a pattern about the receiver */
    uint32_t    material_count;     /* of materials */
    int         add;                /* not 0: results are added to those that are there, of other lists or of
                                       light maps; 0: results are written */
    rsm_visible_fn visible_fn;      /* shadows of the bounced light. Needs lights that all receivers share:
                                       sample_count 0, the pattern FLUX, or a list. Black texels give no light
                                       then, not even by lobes. NULL = every light is seen */
    void       *visible_user;       /* given to visible_fn */
} rsm_gather_desc;

typedef struct rsm_gather_stats {   /* what a gather counted */
    uint64_t evaluated;             /* receivers for which light was gathered */
    uint64_t pairs;                 /* pairs of a receiver and a pixel light that were evaluated */
    uint64_t bad_points;            /* receivers that are not finite or beyond 1e9; their results are 0 */
    double   clamped_share;         /* the light that clamp and near_limit took off, as a share of the light
                                       without them, all channels together */
    double   outside_share;         /* the share of flux that lies beyond r_max, as the mean over 64
                                       receivers */
} rsm_gather_stats;

#ifndef RSM_WITHOUT_INTERPOLATION
/* ---- pictures by interpolation (section 4) ---- */

typedef struct rsm_interpolation {  /* zero it, then set what you care about */
    uint32_t step;                  /* pixels between samples of the coarse grid, a power of two, 2..64;
                                       0 = 8 */
    uint32_t level_count;           /* grids that are tried, each of half the step, before the pixels left are
                                       evaluated one by one: 1 (as in the paper) to 6; 0 = 6 */
    float    normal_cosine;         /* the least cosine between a sample's normal and the pixel's, -1..1;
                                       0 = 0.95 */
    float    plane_slope;           /* how far a sample may lie off the pixel's plane, as a share of its
                                       distance from the pixel, 0..1e6; 0 = 0.05 */
    float    distance;              /* how far a sample may be from the pixel, world units, 0..1e9; 0 = no
                                       limit */
    float    contrast;              /* the grid is refined if the largest difference of the samples is above
                                       this share of their mean, up to 1e6. 0 = 0.25; negative = never, as in
                                       the paper */
    float    light_share;           /* a sample is used only for pixels within this share, up to 1e6, of the
                                       distance from the sample to its nearest pixel light, so that no bright
                                       spot between samples is missed. 0 = 0.25; negative = no limit */
    uint8_t *mask;                  /* a byte a pixel, written: 0 no receiver, 1 interpolated, 2 evaluated.
                                       NULL = not wanted */
} rsm_interpolation;

RSM_DEF rsm_result rsm_interpolate(const rsm_map *const *maps, size_t map_count, const rsm_gather_desc *desc,
                                   const rsm_interpolation *interpolation, const rsm_points *points,
                                   float *irradiance, rsm_gather_stats *stats);
/* Writes the irradiance of all pixels of a picture, as rsm_gather does, but faster: light is gathered on a
   coarse grid of pixels, and interpolated for a pixel if 3 or 4 samples about it lie on a surface like its
   own. The grid is refined for the other pixels, and light is gathered for what is left.
   desc     NULL = all defaults; noise, interleave and add must be off
   interpolation   NULL = all defaults
   points   a picture: width is set, count is a multiple of width below 2^32, and indices is NULL
   stats    may be NULL; evaluated / points->count is the share of pixels for which light was gathered
   Errors   those of rsm_gather, and these.
            RSM_ERR_ARGUMENT: the points are no picture.
            RSM_ERR_DESC: a field of interpolation is out of range, or noise, interleave or add is not off. */
#endif

#ifndef RSM_WITHOUT_LISTS
/* ---- lists of pixel lights ---- */

RSM_DEF rsm_result rsm_gather_list(const rsm_texel *lights, size_t count, const rsm_gather_desc *desc,
                                   const rsm_points *points, float *irradiance, rsm_gather_stats *stats);
/* Writes the irradiance that reaches each receiver from a list of pixel lights, as rsm_gather does from maps.
   The lights may come from rsm_pixel_lights, from rsm_cluster or from anywhere else.
   lights   position, normal (unit), flux and, for near_limit, area are read. Lights that are not finite,
            beyond 1e9, of negative flux or above 1e18 W are left out
   desc     NULL = all defaults. pattern, sample_count, r_max, r_min, seed, noise, near_field and materials
            are not used
   Errors   those of rsm_gather.
            RSM_ERR_INPUT: also if a light's normal is not unit, nor 0 0 0. */

RSM_DEF rsm_result rsm_pixel_lights(const rsm_map *const *maps, size_t map_count, uint32_t sample_count,
                                    uint32_t seed, rsm_texel *lights, size_t capacity, size_t *count);
/* Writes a list of pixel lights that stands for whole maps.
   sample_count  texels that are chosen of each map, in proportion to their flux, 1..2^20; their flux and area
                 are scaled, so that the sum stays. 0 = every lit texel
   seed          chooses between equally good samples
   lights        room for capacity lights; may be NULL if capacity is 0
   count         how many lights there are, written on RSM_OK and on RSM_ERR_MEMORY: ask first with capacity 0
   Errors        the log is that of the first map.
                 RSM_ERR_ARGUMENT: a pointer is NULL, map_count is 0, or sample_count is above 2^20.
                 RSM_ERR_ORDER: a map is not finished.
                 RSM_ERR_MEMORY: capacity is below *count. */

RSM_DEF rsm_result rsm_cluster(const rsm_texel *lights, size_t light_count, uint32_t cluster_count,
                               const rsm_system *system, rsm_texel *clusters, size_t *count);
/* Groups lights into at most cluster_count larger ones. The flux and area of a group are sums, its position
   and normal are means by flux; if its normals cancel out, its normal is that of its brightest light. Lights
   that are not finite, beyond 1e9, without flux or above 1e18 W are left out.
   light_count    below 2^31
   cluster_count  1..65536
   system    may be NULL
   clusters  room for cluster_count lights, of which *count are written; none if there is no flux
   Errors    RSM_ERR_ARGUMENT: a pointer is NULL, or cluster_count is out of range.
             RSM_ERR_DESC: the allocator is not whole.
             RSM_ERR_INPUT: a light's normal is not unit, nor 0 0 0.
             RSM_ERR_LIMIT: light_count is 2^31 or more.
             RSM_ERR_ALLOC: there is no memory.
   Cost      scratch of 4 bytes a light and 128 a cluster */
#endif

/* ---- patterns ---- */

RSM_DEF rsm_result rsm_pattern_build(rsm_pattern pattern, uint32_t sample_count, float r_min,
                                     int paper_weights, uint32_t seed, float *points);
/* Writes one of the patterns about the receiver, for a renderer of your own: a list of samples in the unit
   disc. The mean of a function f over the disc is sum(weight f) / pi.
   pattern        neither FLUX nor MIXED, which are no discs
   sample_count   1..2^20, of POISSON 1..4096
   r_min, paper_weights, seed   as in rsm_gather_desc
   points         3 floats for each sample: x, y and weight
   Errors         this call has no log.
                  RSM_ERR_ARGUMENT: points is NULL, or pattern, sample_count or r_min is out of range. */

RSM_DEF rsm_result rsm_blue_noise(uint32_t side, uint32_t seed, const rsm_system *system, float *values);
/* Makes noise for rsm_gather_desc.noise whose neighbours differ as much as can be, by void and cluster
   (Ulichney 1993). The tile goes on at its borders.
   side      4..64
   system    may be NULL
   values    side^2 floats: (i + 0.5) / side^2 for each i, in the order that makes the noise
   Errors    RSM_ERR_ARGUMENT: values is NULL, or side is out of range.
             RSM_ERR_DESC: the allocator is not whole.
             RSM_ERR_ALLOC: there is no memory.
   Cost      a time of O(side^4), scratch of 4 bytes a value */

#ifdef __cplusplus
}
#endif

#endif /* RSM_H */
