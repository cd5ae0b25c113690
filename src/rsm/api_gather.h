/* ---- bounced light ---- */

typedef enum rsm_pattern {
    RSM_PATTERN_DEFAULT,            /* = RSM_PATTERN_FLUX */
    RSM_PATTERN_FLUX,               /* texels in proportion to flux, the same for all receivers */
    RSM_PATTERN_EQUATION3,          /* the paper's: about the receiver's projection, density 1/r */
    RSM_PATTERN_LOG_RADIAL,         /* density 1/r^2 from r_min out, a uniform disc inside it */
    RSM_PATTERN_POISSON,            /* uniform disc with a least distance; 4096 samples at most */
    RSM_PATTERN_LOW_DISCREPANCY,    /* uniform disc, a (0, 2)-sequence */
    RSM_PATTERN_MIXED,              /* two fifths FLUX, three LOG_RADIAL with r_min 1/192, by multiple
                                       importance sampling: least error in corners, slower. r_max and r_min
                                       are not used */
    RSM_PATTERN_COUNT
} rsm_pattern;

typedef struct rsm_material {       /* a Phong lobe beside the diffuse flux; its energy is bounded by
                                       specular */
    float specular[3];              /* 0..1 */
    float exponent;                 /* 0..1e4 */
} rsm_material;

typedef struct rsm_gather_desc {
    rsm_system  system;
    rsm_pattern pattern;
    uint32_t    samples;            /* texels that each receiver takes of each map, 1..2^20; 0 = every texel,
                                       whatever the pattern */
    int         paper_weights;      /* of EQUATION3: not 0: xi^2, normalised, as the paper has them; biased */
    float       r_max;              /* radius of the pattern in sides of the map. Above 0: samples outside the
                                       map count as dark, and what lies beyond is lost. 0: each ray ends at
                                       the map's border. Cubes: the sine of half the angle, 1 = all round */
    float       r_min;              /* of LOG_RADIAL: share of the radius, below 1; 0 = 1/32 */
    float       offset;             /* world units that pixel lights move below their surface; >= 0 (section
                                       3.2) */
    float       clamp;              /* bound on cos cos / d^2, 1 / unit^2; 0 = none */
    float       near_limit;         /* bound on what one light gives, in its own radiosity (1 is what an
                                       infinite wall gives); 0 = none. Asks for the texels' areas */
    float       near_field;         /* texels nearer than this times their side (the root of their area) are
                                       no points but the parallelograms of surface that they are, by their
                                       form factors: 3 does; 0 = none, at most 32. Of every texel (samples 0)
                                       and of patterns about the receiver; not of lights by flux, nor of
                                       lists. offset moves them, near_limit and clamp bound them as they do
                                       points; lobes are as at their centre */
    uint32_t    seed;               /* another seed is another choice of samples: each frame, before
                                       gifilter.h */
    const float *noise;             /* noise_side^2 floats in 0..1, tiled over the picture: turns the pattern
                                       of each pixel (not FLUX). rsm_blue_noise makes one. NULL = none */
    uint32_t    noise_side;         /* 1..4096 */
    uint32_t    interleave;         /* k: pixel (x, y) takes set x % k + k (y % k) of k x k sets that share
                                       the samples; 1, 2, 4, 8; 0 = 1. Above 1 for pictures alone
                                       (points->width). gifilter.h with log2 k passes puts the sets
                                       together */
    const rsm_material *materials;  /* NULL: all texels are diffuse. Texels with material m have the lobe
                                       materials[m - 1]. FLUX picks by diffuse flux: with samples, the lobes
                                       of black texels need a pattern about the receiver */
    uint32_t    material_count;
    int         add;                /* not 0: results are added to what is there: several lists, light maps */
} rsm_gather_desc;

typedef struct rsm_gather_stats {
    uint64_t evaluated;             /* receivers that were gathered for */
    uint64_t pairs;                 /* of receiver and pixel light */
    uint64_t bad_points;            /* not finite or beyond 1e9: result 0 */
    double   clamped_share;         /* light lost by clamp and near_limit / light without them, channels
                                       together */
    double   outside_share;         /* flux beyond r_max, mean over receivers (64 of them are looked at) */
} rsm_gather_stats;

/* ---- pictures by interpolation (section 4) ---- */

typedef struct rsm_interpolation {
    uint32_t step;                  /* pixels between samples of the coarse grid, a power of two, 2..64;
                                       0 = 8 */
    uint32_t levels;                /* grids tried, each of half the step, before pixels are evaluated one by
                                       one, at most 6; 0 = all; 1 = the paper */
    float    normal_cosine;         /* a sample's normal and the pixel's have at least this cosine;
                                       0 = 0.95 */
    float    plane_slope;           /* a sample lies off the pixel's plane at most this times its distance;
                                       0 = 0.05 */
    float    distance;              /* world units that a sample may be off; 0 = no limit */
    float    contrast;              /* largest difference of the samples / their mean, above which the grid is
                                       refined. 0 = 0.25; negative = not asked, as in the paper */
    float    reach;                 /* a sample is good up to this times its distance from the nearest pixel
                                       light, so that no bright spot is missed between samples. 0 = 0.25;
                                       negative = not asked */
    uint8_t *mask;                  /* NULL, or one byte a pixel is written: 0 none, 1 interpolated, 2
                                       evaluated */
} rsm_interpolation;

RSM_DEF rsm_result rsm_interpolate(const rsm_map *const *maps, size_t map_count, const rsm_gather_desc *desc,
                                   const rsm_interpolation *interpolation, const rsm_points *points,
                                   float *irradiance, rsm_gather_stats *stats);
/* As rsm_gather for a picture (points->width, no indices), most pixels by interpolation between 3 or 4
   samples of a grid that look alike; only what is left is evaluated. stats->evaluated / pixels is the share
   that was.
   desc     NULL = all defaults; noise, interleave and add must be off (RSM_ERR_DESC)
   interpolation   NULL = all defaults */

/* ---- lists of pixel lights ---- */

RSM_DEF rsm_result rsm_gather_list(const rsm_texel *lights, size_t count, const rsm_gather_desc *desc,
                                   const rsm_points *points, float *irradiance, rsm_gather_stats *stats);
/* As rsm_gather, from a list of pixel lights of any origin. pattern, samples, r_max, seed, noise, near_field
   and materials are not used; area is used by near_limit. */

RSM_DEF rsm_result rsm_pixel_lights(const rsm_map *const *maps, size_t map_count, uint32_t samples,
                                    uint32_t seed, rsm_texel *lights, size_t capacity, size_t *count);
/* Writes lights that stand for whole maps.
   samples   of each map, in proportion to flux, with flux and area scaled; 0 = every lit texel
   count     written on RSM_OK and RSM_ERR_MEMORY: lights needed. To ask for it, lights is NULL and capacity
             0 */

RSM_DEF rsm_result rsm_cluster(const rsm_texel *lights, size_t light_count, uint32_t cluster_count,
                               const rsm_system *system, rsm_texel *clusters, size_t *count);
/* Groups lights into at most cluster_count area lights. Flux and area are sums, position and normal means by
   flux; if the normals of a group cancel out, its normal is that of its brightest light.
   light_count    at most 2^31 - 1
   cluster_count  1..65536
   clusters  room for cluster_count; *count of them are written, none if there is no flux
   Errors    RSM_ERR_ARGUMENT, RSM_ERR_ALLOC (4 bytes a light, 128 a cluster). system may be NULL */

/* ---- patterns ---- */

RSM_DEF rsm_result rsm_pattern_build(rsm_pattern pattern, uint32_t samples, float r_min, int paper_weights,
                                     uint32_t seed, float *points);
/* Writes a pattern in the unit disc: x, y and weight of each sample, 3 floats. The mean of f over the disc is
   sum(weight f) / pi.
   Errors    RSM_ERR_ARGUMENT (pattern FLUX or MIXED, samples 0 or above 2^20, POISSON above 4096, r_min not
             in 0..1) */

RSM_DEF rsm_result rsm_blue_noise(uint32_t side, uint32_t seed, const rsm_system *system, float *values);
/* Writes side^2 values (i + 0.5) / side^2, each once, by void and cluster (Ulichney 1993); they tile. Takes a
   time of O(side^4).
   side      4..64
   Errors    RSM_ERR_ARGUMENT, RSM_ERR_ALLOC (4 bytes a value). system may be NULL */

#ifdef __cplusplus
}
#endif

#endif /* RSM_H */
