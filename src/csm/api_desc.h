/* ---- settings of a build ---- */

typedef enum cohsm_domain_kind {    /* where the maps look from: a mapping D of d parameters in 0..1 to
                                       directions towards the light (w = 0), or to positions on it (w = 1) */
    COHSM_DOMAIN_DEFAULT,           /* = COHSM_DOMAIN_LATLONG */
    COHSM_DOMAIN_LATLONG,           /* d = 2, w = 0: s = 0.5 + atan2(z, x) / 2 pi, t = acos(y) / pi; row 0 is
                                       +Y */
    COHSM_DOMAIN_OCTAHEDRAL,        /* d = 2, w = 0: equal-area octahedral square (Clarberg 2008); needs
                                       side[0] = side[1] */
    COHSM_DOMAIN_LINE,              /* d = 1, w = 1: origin + s u */
    COHSM_DOMAIN_RECTANGLE,         /* d = 2, w = 1: origin + s u + t v */
    COHSM_DOMAIN_DISC,              /* d = 2, w = 1: a disc about origin; u and v are its two half axes */
    COHSM_DOMAIN_SPHERE,            /* d = 2, w = 1: the surface of the sphere of radius |u| about origin,
                                       latitude-longitude of equal area */
    COHSM_DOMAIN_VOLUME,            /* d = 3, w = 1: origin + s u + t v + r w */
    COHSM_DOMAIN_TABLE,             /* d = 1..3: a mapping of your own, given by its values at the cells'
                                       centres in `locations` */
    COHSM_DOMAIN_LIST,              /* d = 0: any set of locations, such as virtual lights; asked by index and
                                       never interpolated */
    COHSM_DOMAIN_KIND_COUNT
} cohsm_domain_kind;

typedef struct cohsm_domain {
    cohsm_domain_kind kind;
    uint32_t side[3];               /* cells along each dimension, 1..4096 (TABLE: 1..2^24). Their product N
                                       is the number of maps, at most 2^24. 0 = 128, or 32 for each of three
                                       dimensions */
    float origin[3], u[3], v[3], w[3]; /* the shape of LINE to VOLUME, in the mesh's space and units */
    const float *locations;         /* TABLE, LIST: x, y, z, w of each; all w are equal, 0 or 1. They are
                                       copied */
    size_t location_count;          /* TABLE: the product of side; LIST: N, and side is ignored */
} cohsm_domain;

typedef enum cohsm_layers {         /* z1, z2, z3 are the depths at which the ray of a pixel meets the object
                                       first, second and third. A stored depth may be anything from z1
                                       up to: */
    COHSM_LAYERS_DEFAULT,           /* = COHSM_LAYERS_Z1Z2 */
    COHSM_LAYERS_Z1Z2,              /* z2, or see open_thickness: right for every receiver */
    COHSM_LAYERS_Z1Z3_SPHERE,       /* z3, or where the ray leaves the bounding sphere: for closed surfaces */
    COHSM_LAYERS_Z1Z3_FAR,          /* z3, or infinity: for closed surfaces that have nothing else behind
                                       them */
    COHSM_LAYERS_COUNT
} cohsm_layers;

typedef enum cohsm_order {          /* the sequence in which maps are stored; the more alike neighbours look,
                                       the smaller the block */
    COHSM_ORDER_DEFAULT,            /* cohsm_build tries orders on small versions of the build, which takes a
                                       fifth of its time; a cohsm_builder takes HILBERT */
    COHSM_ORDER_SCANLINE,           /* the first dimension runs fastest */
    COHSM_ORDER_ZIGZAG,             /* the same, with every other line backwards */
    COHSM_ORDER_ZIGZAG_THETA,       /* zig-zag with the second dimension fastest */
    COHSM_ORDER_HILBERT,            /* Hilbert's curve for any sides; no step is diagonal for powers of two */
    COHSM_ORDER_COUNT
} cohsm_order;

typedef enum cohsm_orientation {    /* which way is up in the image of a direction's map */
    COHSM_ORIENTATION_DEFAULT,      /* cohsm_build tries them together with the order; a cohsm_builder takes
                                       POLAR */
    COHSM_ORIENTATION_POLAR,        /* right along rising s of LATLONG, up towards +Y */
    COHSM_ORIENTATION_MINIMAL,      /* the image of +Y by the shortest rotation; turns fast near -Y */
    COHSM_ORIENTATION_TWO_POLES,    /* the shortest rotation from the nearer of +Y and -Y; jumps at the
                                       equator */
    COHSM_ORIENTATION_COUNT
} cohsm_orientation;

typedef struct cohsm_desc {         /* zero it, then set what you care about */
    cohsm_system system;
    cohsm_domain domain;
    uint32_t     map_side;          /* M, the pixels a side of a map, 4..1024; 0 = 128 */
    cohsm_layers layers;
    cohsm_order  order;
    cohsm_orientation orientation;  /* of directions alone */
    uint32_t     depth_bits;        /* the stored depths lie on a grid of so many bits, 4..8; 0 = 8. Where no
                                       grid value separates the layers, a depth is kept in 16 bits: fewer
                                       bits make more segments, and never a wrong answer */
    float        open_thickness;    /* map pixels, >= 0; 0 = 8. How far behind a surface without a second hit
                                       (a leaf, an open border) its stored depth may lie, since receivers may
                                       be right behind it; map_side or more: as far as the bounding sphere
                                       goes, as in the paper */
    int          self_only;         /* not 0: pixels that nothing hits may store anything, which makes a
                                       smaller block that answers for the object's own surface alone */
    float        center[3], radius; /* a sphere that holds the mesh; radius 0 = fitted (a cohsm_builder needs
                                       it) */
    uint32_t     pixel_begin, pixel_end;   /* a shard, for cohsm_merge: pixels begin..end - 1 of every map
                                       alone, of map_side^2; 0, 0 = all */
} cohsm_desc;

typedef struct cohsm_stats {        /* what a build counted; every field may be read after COHSM_OK */
    uint64_t segments;              /* in all lists */
    uint64_t exact_depths;          /* segments of one map that are kept in 16 bits, since no value of the
                                       grid separates its layers */
    uint64_t empty_intervals;       /* pixels of views in which the layer that bounds the stored depth lies at
                                       z1: z1 is stored, and the query's bias is needed */
    uint64_t open_entries;          /* pixels of views with one hit only: they see an open border or a
                                       sheet */
    uint32_t triangles;             /* used */
    uint32_t skipped_triangles;     /* a vertex was not finite, or two corners were equal */
    uint32_t duplicate_triangles;   /* had the same three corners as an earlier one, in any order */
    cohsm_order order;              /* the one taken */
    size_t   peak_bytes;            /* the most that the allocator had given out at once */
} cohsm_stats;

COHSM_DEF cohsm_result cohsm_budget(const cohsm_desc *desc, const cohsm_mesh *mesh, size_t bytes,
                                    uint32_t *side, uint32_t *map_side);
/* Finds the side of LATLONG or OCTAHEDRAL and the pixels a side of a map, M, that have the least expected
   error of all whose block stays below so many bytes. Sizes are measured on builds of side 16 and 32 and
   continued by their growth, with a tenth in reserve. The error is 0.0055 (128 / side) + 0.0185 sqrt(128
   / M): the shares of rays that snapping to directions and to pixels gets wrong on the bunny (docs/csm.md).
   desc     NULL = all defaults; its side and map_side are ignored
   Errors   those of cohsm_build; COHSM_ERR_MISMATCH (another domain); COHSM_ERR_LIMIT where not even side 8,
            M = 16 fits
   Cost     about a build of side 40 */
