/* ---- settings ---- */

typedef struct ism_allocator {      /* all zero: malloc and free; else both functions */
    void *(*alloc_fn)(size_t bytes, void *user);    /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} ism_allocator;

typedef void (*ism_task)(void *context, size_t index);

typedef struct ism_system {         /* all zero: malloc and free, this thread alone, no progress, no log */
    ism_allocator allocator;        /* called from the thread that called us */
    void (*parallel_for)(void *user, size_t count, ism_task task, void *context);
    /* Must call task(context, i) once for each i < count, in any order and on any threads, and return when
       all are done. What is computed does not depend on the threads. */
    int (*progress)(void *user, float fraction);
    /* Called from the thread that called us, fraction 0..1 never falling within a call; not 0 cancels. */
    void (*log)(void *user, const char *message);
    /* Called at most once by a call that fails, from the thread that called us, before it returns: one line
       without a line end that names the function, the field or element, its value and its range. */
    void *user;                     /* given to parallel_for, progress and log */
} ism_system;

typedef enum ism_importance {       /* by what VPLs are chosen among the texels of sources */
    ISM_IMPORTANCE_DEFAULT,         /* = ISM_IMPORTANCE_GUIDED */
    ISM_IMPORTANCE_FLUX,            /* the power that leaves the texel (paper, section 3.2) */
    ISM_IMPORTANCE_BRSM,            /* times its mean effect on receivers drawn from a jittered grid (section
                                       4.1) */
    ISM_IMPORTANCE_GUIDED,          /* half of these drawn near the texel's place in the picture (section
                                       4.2) */
    ISM_IMPORTANCE_COUNT
} ism_importance;

typedef enum ism_spread {           /* how surfels are spread over triangles */
    ISM_SPREAD_DEFAULT,             /* = ISM_SPREAD_PAIR */
    ISM_SPREAD_AREA,                /* evenly, as in imperfect shadow maps of 2008 */
    ISM_SPREAD_VIEW_1,              /* by solid angle, seen from one receiver for all triangles (section
                                       5.1) */
    ISM_SPREAD_VIEW_8,              /* by solid angle, seen from 8 receivers for each triangle (section
                                       5.2) */
    ISM_SPREAD_PAIR,                /* by the geometric mean of that and of what the VPL sees */
    ISM_SPREAD_COUNT
} ism_spread;

typedef enum ism_projection {       /* which direction a texel of a VPL's map shows */
    ISM_PROJECTION_DEFAULT,         /* = ISM_PROJECTION_COSINE */
    ISM_PROJECTION_COSINE,          /* every texel has an equal share of a diffuse VPL's flux (section 6.1) */
    ISM_PROJECTION_PARABOLOID,      /* a disc in the square, whose corners are never used */
    ISM_PROJECTION_OCTAHEDRAL,      /* no trigonometry; texels of 0.6 to 1.7 times the mean solid angle */
    ISM_PROJECTION_LOBE,            /* every texel has an equal share of the flux of the VPL's own lobe */
    ISM_PROJECTION_COUNT
} ism_projection;

struct ism_desc {                   /* zero it, then set what you care about */
    ism_system     system;          /* kept: the maps' later calls use it too */
    uint32_t       vpl_count;       /* N, 1..16384; 0 = 1024 */
    uint32_t       surfel_count;    /* of each VPL, 8..65536; 0 = 8192 */
    uint32_t       tile_side;       /* texels a side of a VPL's map, a power of two, 8..256; 0 = 64 */
    ism_importance importance;
    ism_spread     spread;
    ism_projection projection;
    uint32_t       view_grid_side;  /* receivers that a texel's effect is estimated from: the grid's side,
                                       1..16; 0 = 4 */
    int32_t        blur_radius;     /* texels that effects are blurred over, at most 16; 0 = 5 % of the
                                       source's shorter side, at most 6; negative = no blur */
    uint32_t       lazy_frames;     /* frames until all surfels are renewed, 1..64; 0 = 8 */
    float          flux_share;      /* of the choice made by flux alone, above 0, <= 1; 0 = 0.1: no texel is
                                       forgotten */
    float          area_share;      /* of the surfels spread evenly, above 0, <= 1; 0 = 0.2: no triangle is
                                       forgotten */
    float          splat_scale;     /* area of discs over that of their surfels, above 0, <= 16; 0 = 1. Discs
                                       that are cut off at their triangle's edges have 6 times that, which
                                       closes gaps between them */
    int32_t        near_point_count;    /* of each VPL, which light in its place what is near, at most 64;
                                       0 = 16; negative = none: ISM_NEAR_GATHER is ISM_NEAR_PATCH then */
    int32_t        window_rim;      /* texels a side of a tile for what lies outside of its window (ism_zoom),
                                       2..tile_side / 2; 0 = tile_side / 8, at least 2; negative = tiles have
                                       no windows and show hemispheres evenly */
    int            no_inter_texel;  /* not 0: VPLs lie at texel centres of their source, not between them
                                       (section 6.5) */
    int            no_fill;         /* not 0: holes of maps stay open, without pull and push (section 3.3) */
    int            unstable;        /* not 0: new random numbers every frame: means of frames converge;
                                       flickers */
    int            vary_surfels;    /* not 0: weak VPLs take a half or a quarter of the surfels */
    int            keep_hits;       /* not 0: the atlas keeps which triangles it shows, for ism_bounce */
    uint32_t       seed;
};

typedef enum ism_near {             /* what is done about receivers close to a VPL */
    ISM_NEAR_DEFAULT,               /* = ISM_NEAR_GATHER */
    ISM_NEAR_PATCH,                 /* the VPL becomes a square of its area, by its exact form factor; to
                                       receivers that face the square no brighter than a point, as the backs
                                       of bent sheets do */
    ISM_NEAR_SPHERE,                /* the VPL becomes a virtual spherical light, Hasan et al. 2009 */
    ISM_NEAR_CLAMP,                 /* cos cos / d^2 is `clamp` at most */
    ISM_NEAR_CLAMP_MEAN,            /* a VPL's light is at most `clamp` times the mean over the receiver's
                                       VPLs */
    ISM_NEAR_NONE,                  /* nothing: bright specks */
    ISM_NEAR_GATHER,                /* near points, each a square too, take the place of VPLs within reach,
                                       smoothly */
    ISM_NEAR_COUNT
} ism_near;

typedef void (*ism_visible_fn)(void *user, const float position[3], const float geometric_normal[3],
                               const uint32_t *numbers, size_t count, float *visible);
/* Writes 0..1, how much of each of count lights is seen from a receiver. numbers: of VPLs (ism_vpls) or of
   near points (ism_near_points). Called from several threads at once where parallel_for uses them. */

struct ism_shading {                /* zero it, then set what you care about */
    uint32_t       pattern;         /* 1, 2, 4, 8: every pixel takes 1 / pattern^2 of the VPLs, and a blur
                                       mixes the neighbours (section 6.2); 0 = 1. Not for lists */
    ism_near       near_mode;
    float          clamp;           /* of ISM_NEAR_CLAMP in 1/m^2, of ISM_NEAR_CLAMP_MEAN a factor; 0 = 1 */
    float          bias;            /* share of their distance by which receivers count as nearer, below 1; 0
                                       = 0.02; negative = none */
    int            no_maps;         /* not 0: nothing casts shadows */
    int            cull;            /* not 0: skips VPLs that face away from blocks of 16 x 16 pixels; same
                                       picture */
    ism_visible_fn visible_fn;      /* exact visibility of VPLs in place of the maps; NULL = the maps */
    void          *visible_user;
    ism_visible_fn near_visible_fn; /* the same of near points; NULL: each is seen as its VPL is, by
                                       visible_fn or by the maps */
    void          *near_visible_user;
};

struct ism_stats {                  /* of the last run of each stage */
    uint32_t vpls;                  /* fewer than N only where the sources are black */
    uint32_t jumped;                /* VPLs that moved farther than a texel since the last frame */
    uint64_t bad_pvpls;             /* texels of sources that are not finite, negative, above 1e30, or whose
                                       unit vectors are 0 0 0: never chosen */
    uint64_t skipped_triangles;     /* a vertex is not finite, or the area is 0 */
    uint64_t surfels, renewed;      /* all, and those of this frame */
    uint64_t splats;                /* surfels that were drawn into tiles */
    uint64_t wide_splats;           /* of them, discs that would be wider than they are far, and were cut */
    uint64_t filled;                /* texels that pull and push wrote */
    double   surface_area;          /* of the mesh, m^2 */
    double   flux[3];               /* of all sources, W (surfaces alone) */
    double   lost_energy;           /* share of the light that the rule for near VPLs took off, mean of all
                                       channels; by PATCH also what would have leaked through bent sheets */
    double   culled;                /* share of pairs of VPL and block that culling skipped */
    size_t   bytes, peak_bytes;     /* asked of the allocator: now, and at most (from ism_shade: with its
                                       own) */
    uint32_t near_points;           /* of the last ism_choose; 0 after ism_set_vpls */
};
