/* ---- scenes: what they hold ---- */

enum { SFIELD__CACHED = 256 };      /* wavelets of T that the lazy cache keeps for a point and light */

#define SFIELD__NONE 0xffffffffu     /* no entity */

typedef struct sfield__item {       /* of an entity */
    sfield_entity e;
    float    turn[9];               /* world to field directions, rows */
    float center[2][3], inverse[2], radius[2]; /* of occlusion and source: world center, 1 / (scale r), world
                                                  radius */
    float    inscribed, reach;      /* of the occluder, world */
    float    was[3];                /* center[0] before the last change of the scene */
    int      identity;
#ifndef SFIELD_WITHOUT_ROOMS
    int      holds;                 /* not 0: a light lies in the hull of the occluder */
#endif
    uint32_t map;                   /* wavelets, rotated: 1 + which resampling table */
    uint64_t field, body, light;    /* hashes, 0 where there is none: of the occlusion field, by address and
                                       by checksum, since another one may come to lie at the same address; of
                                       that and where it stands; of the source and all that shines by it */
} sfield__item;

typedef struct sfield__taps { uint16_t texel[4]; float weight[4]; } sfield__taps;

#ifndef SFIELD_WITHOUT_HIERARCHY
typedef struct sfield__ball { float center[3], radius; } sfield__ball;

typedef struct sfield__tree {       /* occluders along a curve, and spheres about what they reach */
    uint64_t     *keys, *order;     /* of each occluder: its place along the curve, and in the lower half its
                                       item. Room for twice as many; half of it, where they are in order */
    sfield__ball *ball, *level[8];  /* of 4 occluders each, of 16, ... */
    uint32_t      count, levels;
} sfield__tree;

typedef struct sfield__walk {       /* how far the occluders are looked through that may reach a sphere */
    const sfield__tree *tree;
    float    middle[3], extent;
    uint32_t at, level;
} sfield__walk;
#endif

#ifndef SFIELD_WITHOUT_ROOMS
struct sfield__tenant { uint32_t light, item; };  /* a light in the hull of an entity: part rooms.h */
static int sfield__find_rooms(sfield_scene *s);
#endif

#ifndef SFIELD_WITHOUT_GLOSS
typedef struct sfield__brdf sfield__brdf;    /* BRDFs as harmonics: part gloss.h */
#endif

struct sfield_scene {
    sfield__allocator allocator;
    sfield_scene_desc desc;
    sfield_algebra   *algebra;
    int               simd;
    uint32_t          coefs, planes, cells, side;
    sfield__item     *item;
    sfield_rotation  *rotation;
    sfield__taps     *taps;
    uint32_t *occluder, *light, item_count, occluder_count;
    uint32_t light_count, overlaps, maps;
#ifndef SFIELD_WITHOUT_HIERARCHY
    sfield__tree tree;
#endif
#ifndef SFIELD_WITHOUT_ROOMS
    struct sfield__tenant *held;      /* lights that lie in the hull of another entity */
    uint32_t          held_count;
#endif
#ifndef SFIELD_WITHOUT_GLOSS
    sfield__brdf     *brdf;         /* harmonics: made when the first set with materials comes */
#endif
    /* Hashes of all that results depend on besides the points: the entities, the environment; both; and both
       as they were before the last change, 0 if that did more than move the occluders of `moved`. */
    uint64_t          entities_hash, sky_hash, now_hash, before_hash;
    uint32_t         *moved, moved_count;
    float            *sky;          /* as set: cube of texels, 3 planes; kept unturned */
    float            *sky_now;      /* harmonics: 3 x n^2; wavelets: 3 x 6 N^2 texels, then their
                                       coefficients */
    float            *sky_still;    /* harmonics: as set, not turned */
    float            *sun;          /* of the sun, as set, not turned */
    int               has_sky, has_sun;
    float             sky_turn[16];
    float            *texel;        /* x, y, z, solid angle: four planes of 6 N^2 */
    uint8_t          *scratch;
    size_t            scratch_bytes;
};

typedef struct sfield__last {       /* a tile or a point, when its results were kept */
    uint64_t seen;                  /* hash of all that they depend on; 0 = nothing kept */
    float    middle[3], extent;     /* a sphere about the points */
    uint32_t in_view, active;       /* bits: points that were in view; those that can be shaded: others give
                                       0 */
    int      has;                   /* which results */
} sfield__last;

struct sfield_cache {
    sfield__allocator allocator;
    size_t    points, bytes;
    uint32_t  lights, coefs, cells; /* cells 0: harmonics */
    uint32_t  chains;               /* room for so many T of a point and light: 1, with gloss 2 or 3 */
    uint64_t *hash;                 /* harmonics: tiles x lights; wavelets: points x lights x chains; 0 =
                                       nothing kept. What follows lies in the memory that begins here */
    int16_t  *value;
    uint16_t *index;                /* wavelets: of each value */
    float    *scale;
    uint64_t *lit;                  /* wavelets: hash and sky that sky is of, 3 floats a point and chain;
                                       harmonics: what the marks of a tile are of */
    float    *sky;
    uint8_t  *marks;                /* harmonics: of each tile, how many T are kept of those that all lights
                                       have in common */
    sfield__last *last;             /* of each tile (harmonics) or point */
    float    *result;               /* of the last frame: r, g, b, ambient of each point, and with room for
                                       gloss three of that and three of grazing */
};
