/* ---- scenes: what they hold ---- */

enum { SFIELD__CACHED = 256 };      /* wavelets of T that the lazy cache keeps for a point and light */

#define SFIELD__NONE 0xffffffffu     /* no entity */

typedef struct sfield__item {       /* of an entity */
    sfield_entity e;
    float    turn[9];               /* world to field directions, rows */
    float center[2][3], inverse[2], radius[2]; /* of occlusion and source: world center, 1 / (scale r), world
                                                  radius */
    float    inscribed, reach;      /* of the occluder, world */
    int      identity;
    uint32_t map;                   /* wavelets, rotated: 1 + which resampling table */
    uint32_t crc;                   /* of the occlusion field: another one may come to lie at the same
                                       address */
} sfield__item;

typedef struct sfield__taps { uint16_t texel[4]; float weight[4]; } sfield__taps;

struct sfield_scene {
    sfield__allocator allocator;
    sfield_scene_desc desc;
    sfield_algebra   *algebra;
    int               simd;
    uint32_t          coefs, planes, cells, side;
    sfield__item     *item;
    sfield_rotation  *rotation;
    sfield__taps     *taps;
    uint32_t         *occluder, *light, item_count, occluder_count, light_count, overlaps, maps;
    uint64_t          version, sky_version;       /* of everything but lights; of the environment */
    float            *sky;          /* as set: cube of texels, 3 planes; kept unturned */
    float            *sky_now;      /* harmonics: 3 x n^2; wavelets: 3 x 6 N^2 texels, then their
                                       coefficients */
    float            *sky_still;    /* harmonics: as set, not turned */
    float            *sun;          /* likewise, not turned */
    int               has_sky, has_sun;
    float             sky_turn[16];
    float            *texel;        /* x, y, z, solid angle: four planes of 6 N^2 */
    uint8_t          *scratch;
    size_t            scratch_bytes;
};

struct sfield_cache {
    sfield__allocator allocator;
    size_t    points, bytes;
    uint32_t  lights, coefs, cells; /* cells 0: harmonics */
    uint64_t *hash;                 /* harmonics: tiles x lights; wavelets: points x lights; 0 = nothing
                                       kept */
    int16_t  *value;
    uint16_t *index;                /* wavelets: of each value */
    float    *scale;
    uint64_t *lit;                  /* wavelets: hash and sky that sky is of, 3 floats a point; harmonics:
                                       what the marks of a tile are of */
    float    *sky;
    uint8_t  *marks;                /* harmonics: of each tile, so many T on the way that all lights share are
                                       kept */
};
