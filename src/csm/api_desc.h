/* ---- settings of a build ---- */

typedef enum cohsm_domain_kind {    /* where the maps look from: a mapping D of d parameters in 0..1 to
                                       directions towards the light (w = 0), or to positions on it (w = 1) */
    COHSM_DOMAIN_DEFAULT,           /* = COHSM_DOMAIN_LATLONG */
    COHSM_DOMAIN_LATLONG,           /* d = 2, w = 0: s = 0.5 + atan2(z, x) / 2 pi, t = acos(y) / pi; row 0 is
                                       +Y */
    COHSM_DOMAIN_OCTAHEDRAL,        /* d = 2, w = 0: the sphere on a square by the equal-area octahedral map
                                       (Clarberg 2008); side[0] and side[1] must be equal */
    COHSM_DOMAIN_LINE,              /* d = 1, w = 1: origin + s u */
    COHSM_DOMAIN_RECTANGLE,         /* d = 2, w = 1: origin + s u + t v */
    COHSM_DOMAIN_DISC,              /* d = 2, w = 1: the disc about origin with the half axes u and v; the
                                       square s, t goes to the disc by Shirley and Chiu's concentric map */
    COHSM_DOMAIN_SPHERE,            /* d = 2, w = 1: the surface of the sphere of radius |u| about origin;
                                       s turns about +Y, t runs with equal areas from +Y to -Y */
    COHSM_DOMAIN_VOLUME,            /* d = 3, w = 1: origin + s u + t v + r w */
    COHSM_DOMAIN_TABLE,             /* d = 1..3: a mapping of your own, given by its values at the cells'
                                       centres in `locations` */
    COHSM_DOMAIN_LIST,              /* d = 0: any set of locations, such as virtual lights, which queries name
                                       by index; PCF takes no mean over locations */
    COHSM_DOMAIN_COUNT
} cohsm_domain_kind;

typedef enum cohsm_layers {         /* how far behind the first hit a stored depth may lie, which makes blocks
                                       smaller. z1, z2, z3 are the depths at which the ray of a pixel meets
                                       the object first, second and third */
    COHSM_LAYERS_DEFAULT,           /* = COHSM_LAYERS_Z1Z2 */
    COHSM_LAYERS_Z1Z2,              /* up to z2, or as open_thickness says if there is no z2: right for every
                                       receiver */
    COHSM_LAYERS_Z1Z3_SPHERE,       /* up to z3, or to where the ray leaves the bounding sphere: for closed
                                       surfaces */
    COHSM_LAYERS_Z1Z3_FAR,          /* up to z3, or without an end: for closed surfaces that have nothing else
                                       behind them */
    COHSM_LAYERS_COUNT
} cohsm_layers;

typedef enum cohsm_order {          /* the sequence in which maps are stored; the more alike neighbours look,
                                       the smaller the block */
    COHSM_ORDER_DEFAULT,            /* LATLONG to VOLUME: cohsm_build tries HILBERT and ZIGZAG_THETA on small
                                       versions of the build, which takes a seventh of its time. HILBERT for
                                       TABLE and a cohsm_builder; LINE and LIST are always SCANLINE */
    COHSM_ORDER_SCANLINE,           /* lines along the first dimension, one after another */
    COHSM_ORDER_ZIGZAG,             /* the same lines, every other one backwards */
    COHSM_ORDER_ZIGZAG_THETA,       /* zig-zag by lines along the second dimension */
    COHSM_ORDER_HILBERT,            /* Hilbert's curve, for any sides; no step is diagonal if the sides are
                                       powers of two */
    COHSM_ORDER_COUNT
} cohsm_order;

typedef enum cohsm_orientation {    /* which way is up in the image of a direction's map */
    COHSM_ORIENTATION_DEFAULT,      /* cohsm_build tries POLAR and TWO_POLES with each order. POLAR for TABLE,
                                       LIST and a cohsm_builder */
    COHSM_ORIENTATION_POLAR,        /* up is towards +Y; right is towards larger s of LATLONG */
    COHSM_ORIENTATION_MINIMAL,      /* axes follow from those at +Y by the shortest rotation to the direction;
                                       they turn fast near -Y */
    COHSM_ORIENTATION_TWO_POLES,    /* the same from the nearer of +Y and -Y; axes jump at the equator */
    COHSM_ORIENTATION_COUNT
} cohsm_orientation;

typedef enum cohsm_layout {         /* how maps lie in memory; answers are the same */
    COHSM_LAYOUT_DEFAULT,           /* = COHSM_LAYOUT_COMPACT */
    COHSM_LAYOUT_COMPACT = COHSM_LAYOUT_DEFAULT,    /* the block alone, which is the file too */
    COHSM_LAYOUT_FAST,              /* the block and, beside it, trays, in which a query finds a depth by
                                       reading 2 bytes and one cache line, without decoding. Trays take about
                                       1.4 times the bytes of the block (cohsm_info.fast_bytes) */
    COHSM_LAYOUT_BUDGET,            /* FAST if block and trays take layout_bytes or less, else COMPACT */
    COHSM_LAYOUT_COUNT
} cohsm_layout;

#ifndef COHSM_WITHOUT_BUILD
typedef struct cohsm_domain {
    cohsm_domain_kind kind;
    uint32_t side[3];               /* cells along each dimension, 1..4096 (TABLE: 1..2^24). Their product N
                                       is the number of maps, at most 2^24. 0 = 128, or 32 for VOLUME, or 1
                                       for TABLE and for dimensions that the kind does not have */
    float origin[3], u[3], v[3], w[3]; /* the shape of LINE to VOLUME, in the mesh's space and units */
    const float *locations;         /* TABLE, LIST: x, y, z, w of each cell, the first dimension fastest; w is
                                       0 for all (x, y, z of any length but 0) or 1 for all. The library
                                       copies them */
    size_t location_count;          /* TABLE: the product of side; LIST: N, 1..2^24, and side is ignored */
} cohsm_domain;

typedef struct cohsm_desc {         /* zero it, then set what you care about */
    cohsm_system system;
    cohsm_domain domain;
    uint32_t     map_side;          /* M, the pixels a side of a map, 4..1024; 0 = 128 */
    cohsm_layers layers;
    cohsm_order  order;
    cohsm_orientation orientation;  /* ignored for maps of positions */
    uint32_t     depth_bits;        /* stored depths lie on a grid of so many bits, 4..8; 0 = 8. If no grid
                                       value separates the layers, a depth is kept in 16 bits: fewer bits
                                       make more segments, but never a wrong answer */
    float        open_thickness;    /* map pixels, >= 0; 0 = 8. How far behind a surface without a second hit
                                       (a leaf, an open border) the stored depth may lie, which leaks light
                                       onto receivers right behind that surface; map_side or more: to the far
                                       side of the bounding sphere, as in the paper */
    int          self_only;         /* not 0: pixels that nothing hits may store anything. The block is
                                       smaller, and answers only for points on the object's own surface */
    float        center[3], radius; /* a sphere that holds the mesh, in the mesh's units, radius 1e-18..1e18;
                                       0 = the sphere is fitted to the mesh, center too (a cohsm_builder,
                                       which has no mesh, needs a sphere) */
    uint32_t     pixel_begin, pixel_end;   /* a shard, for cohsm_merge: only the pixels begin..end - 1 of the
                                       map_side^2 of every map are built; 0, 0 = all */
    cohsm_layout layout;            /* how the finished maps lie in memory */
    size_t       layout_bytes;      /* of COHSM_LAYOUT_BUDGET: the most that block and trays may take */
} cohsm_desc;

typedef struct cohsm_stats {        /* what a build counted */
    uint64_t segments;              /* segments of all pixels together */
    uint64_t exact_depths;          /* segments of one view whose depth is kept in 16 bits, since no value of
                                       the grid separates the layers */
    uint64_t empty_intervals;       /* pixels of views whose next layer lies at z1 itself: z1 is stored, and
                                       only a query's bias keeps the surface from shadowing itself */
    uint64_t open_entries;          /* pixels of views with one hit only: they see an open border or a
                                       sheet */
    uint32_t triangles;             /* triangles that were used */
    uint32_t skipped_triangles;     /* triangles left out because a vertex was not finite or two corners were
                                       equal */
    uint32_t duplicate_triangles;   /* triangles left out because an earlier one had the same three corners,
                                       in any order */
    cohsm_order order;              /* the sequence in which the maps are stored: desc.order, or the one that
                                       COHSM_ORDER_DEFAULT and the kind of the domain led to */
    size_t   peak_bytes;            /* the most bytes that the allocator had given out at once */
} cohsm_stats;

COHSM_DEF cohsm_result cohsm_budget(const cohsm_desc *desc, const cohsm_mesh *mesh, size_t bytes,
                                    uint32_t *side, uint32_t *map_side);
/* Finds the side of a LATLONG or OCTAHEDRAL domain and the side M of a map with the least expected error
   among those whose block is expected to stay below so many bytes. The size of a block is measured on builds
   of side 16 and 32 and continued by their growth, with a tenth in reserve. The expected error is
   0.0055 (128 / side) + 0.0185 sqrt(128 / M), the share of rays that snapping to directions and to pixels
   gets wrong on the bunny (docs/csm.md).
   desc     NULL = all defaults; its domain.side, map_side, pixels of a shard and layout are ignored
   side, map_side   receive what to write into domain.side[0], domain.side[1] and map_side, on COHSM_OK only
   Errors   those of cohsm_build; COHSM_ERR_DESC also for another domain, COHSM_ERR_LIMIT also if not even
            side 8 with M = 16 fits
   Cost     about that of a build of side 40 */
#endif
