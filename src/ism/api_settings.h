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

typedef enum ism_importance {       /* by which importance VPLs are chosen among the texels of sources */
    ISM_IMPORTANCE_DEFAULT,         /* = ISM_IMPORTANCE_GUIDED */
    ISM_IMPORTANCE_FLUX,            /* by the flux that leaves the texel (paper, section 3.2) */
    ISM_IMPORTANCE_BRSM,            /* by flux x effect on the picture (section 4.1). The effect is the root
                                       of a mean square: of what a unit of the texel's flux would add,
                                       unshadowed, to receivers at view_grid_side^2 jittered places of the
                                       picture. So the picture's variance is least. blur_radius blurs the mean
                                       square, flux_share adds a constant to its root */
    ISM_IMPORTANCE_GUIDED,          /* as BRSM, with half of the receivers near the texel's own place in the
                                       picture (section 4.2); such samples weigh less where they are denser */
    ISM_IMPORTANCE_BRSM_MEAN,       /* as BRSM, but the effect is the mean, as in the paper: VPLs are in
                                       proportion to the light that they add, not to the noise */
    ISM_IMPORTANCE_GUIDED_MEAN,     /* as GUIDED, but the effect is the mean */
    ISM_IMPORTANCE_COUNT
} ism_importance;

typedef enum ism_spread {           /* how surfels are spread over triangles */
    ISM_SPREAD_DEFAULT,             /* = ISM_SPREAD_PAIR */
    ISM_SPREAD_AREA,                /* by area, as in the imperfect shadow maps of 2008 */
    ISM_SPREAD_VIEW_1,              /* by the triangle's solid angle as seen from one receiver, the same for
                                       all triangles (section 5.1) */
    ISM_SPREAD_VIEW_8,              /* by the triangle's mean solid angle as seen from 8 receivers, which are
                                       drawn for each triangle (section 5.2) */
    ISM_SPREAD_PAIR,                /* by the geometric mean of VIEW_8 and of about the share of the VPL's own
                                       map that the triangle fills */
    ISM_SPREAD_COUNT
} ism_spread;

typedef enum ism_projection {       /* which directions the texels of a VPL's map show */
    ISM_PROJECTION_DEFAULT,         /* = ISM_PROJECTION_COSINE */
    ISM_PROJECTION_COSINE,          /* every texel has an equal share of a diffuse VPL's flux (section 6.1) */
    ISM_PROJECTION_PARABOLOID,      /* a disc in the square, whose corners are never used */
    ISM_PROJECTION_OCTAHEDRAL,      /* an octahedron's upper half, which takes no trigonometry; texels have
                                       0.6 to 1.7 times the mean solid angle */
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
    uint32_t       view_grid_side;  /* a texel's effect is estimated from a grid of receivers with this side,
                                       1..16; 0 = 4 */
    int32_t        blur_radius;     /* texels of a source along its surface, to either side, over which
                                       effects are blurred, at most 16; 0 = 5 % of the source's shorter side,
                                       at most 6; negative = no blur */
    uint32_t       lazy_frames;     /* frames until all surfels are renewed, 1..64; 0 = 8 */
    float          flux_share;      /* share of the choice that is made by flux alone, so that no texel is
                                       forgotten, up to 1; 0 = 0.1 */
    float          area_share;      /* share of the surfels that is spread by area, so that no triangle is
                                       forgotten, up to 1; 0 = 0.2 */
    float          splat_scale;     /* area of discs over that of their surfels, up to 16; 0 = 0.8. Discs that
                                       are cut off at their triangle's edges have 6 times the area, which
                                       closes gaps between them */
    int32_t        near_point_count;    /* near points for each VPL, at most 64; 0 = 16; negative = none. Near
                                       points take the VPL's place for receivers close by; if there are none,
                                       ISM_NEAR_GATHER does what ISM_NEAR_PATCH does */
    int32_t        window_rim;      /* texels a side of a tile that show what lies outside its window
                                       (ism_zoom), 2..tile_side / 2; 0 = tile_side / 8, at least 2; negative =
                                       tiles have no windows and show hemispheres evenly */
    int            no_inter_texel;  /* not 0: VPLs lie at texel centres of their source, not between them
                                       (section 6.5) */
    int            no_fill;         /* not 0: holes of maps stay open, without pull and push (section 3.3) */
    int            unstable;        /* not 0: every frame has new random numbers, so that the mean of many
                                       frames converges and single frames flicker; 0: frames stay alike */
    int            vary_surfels;    /* not 0: VPLs with less than a half or a quarter of the mean flux take a
                                       half or a quarter of the surfels */
    int            keep_hits;       /* not 0: the atlas keeps which triangles it shows, for ism_bounce, and
                                       tiles have no windows */
    uint32_t       seed;            /* chooses between equally good sets of random numbers */
};

typedef enum ism_near {             /* what is done where a receiver is so close to a VPL that a point's
                                       light would be a bright speck */
    ISM_NEAR_DEFAULT,               /* = ISM_NEAR_GATHER */
    ISM_NEAR_PATCH,                 /* the VPL is taken for a square of its area, whose exact form factor is
                                       computed. A receiver that faces the square gets no more than from a
                                       point, since it may be the back of a bent sheet */
    ISM_NEAR_SPHERE,                /* the VPL is taken for a virtual spherical light (Hasan et al. 2009) */
    ISM_NEAR_CLAMP,                 /* cos cos / d^2 is cut off at `clamp` */
    ISM_NEAR_CLAMP_MEAN,            /* a VPL's light is cut off at `clamp` times the mean over the receiver's
                                       VPLs */
    ISM_NEAR_NONE,                  /* nothing is done: there are bright specks */
    ISM_NEAR_GATHER,                /* near points, squares too, take the place of VPLs within their reach,
                                       and fade in smoothly */
    ISM_NEAR_COUNT
} ism_near;

typedef void (*ism_visible_fn)(void *user, const float position[3], const float geometric_normal[3],
                               const uint32_t *numbers, size_t count, float *visible);
/* A function of yours, such as a ray tracer's, that writes how much of each light a receiver sees. Several
   threads of parallel_for may call the function at once.
   numbers   which lights are asked for: indices of ism_vpls, or of ism_near_points
   visible   count floats, 0..1 */

struct ism_shading {                /* zero it, then set what you care about */
    uint32_t       interleave;      /* 1, 2, 4, 8: every pixel takes 1 / interleave^2 of the VPLs, and a blur
                                       along surfaces mixes neighbours (section 6.2); 0 = 1. A list of
                                       receivers, which has no neighbours, needs 0 or 1 */
    ism_near       near_mode;
    float          clamp;           /* the bound of ISM_NEAR_CLAMP, 1/m^2, and the factor of
                                       ISM_NEAR_CLAMP_MEAN; 0 = 1 */
    float          bias;            /* receivers count as nearer to the VPL by this share of their distance,
                                       below 1; 0 = 0.02; negative = none */
    int            no_maps;         /* not 0: nothing casts shadows */
    int            cull;            /* not 0: VPLs that face away from a block of 16 x 16 pixels are skipped,
                                       which saves time and changes no picture */
    ism_visible_fn visible_fn;      /* asked in place of the maps, to see VPLs exactly; NULL = the maps */
    void          *visible_user;
    ism_visible_fn near_visible_fn; /* the same for near points; NULL: a near point is seen as its VPL is, by
                                       visible_fn or by the maps */
    void          *near_visible_user;
};

struct ism_stats {                  /* of the last run of each stage */
    uint32_t vpls;                  /* VPLs in use: N at most, none if all sources are black */
    uint32_t jumped;                /* VPLs that moved farther than a texel since the last frame */
    uint64_t bad_pvpls;             /* texels that are never chosen, since their flux, place, normal or lobe
                                       is not finite or out of range, or a unit vector is 0 0 0 */
    uint64_t skipped_triangles;     /* triangles with a vertex that is not finite, or without area */
    uint64_t surfels, renewed;      /* all surfels, and those that this frame made anew */
    uint64_t splats;                /* surfels that were drawn into tiles */
    uint64_t wide_splats;           /* those of `splats` whose disc was made smaller, since it would have been
                                       wider than its distance */
    uint64_t filled;                /* texels that pull and push wrote */
    double   surface_area;          /* of the mesh, m^2 */
    double   flux[3];               /* r, g, b of all sources that are surfaces, W */
    double   lost_energy;           /* share of the light that the rule for near VPLs took off, as the mean of
                                       all channels. PATCH counts the light that would have leaked through
                                       bent sheets, too */
    double   culled;                /* share of the pairs of a VPL and a block that culling skipped */
    size_t   bytes, peak_bytes;     /* memory asked of the allocator: now, and the most at once, which in
                                       ism_shade includes the call's own */
    uint32_t near_points;           /* near points of the last ism_choose; 0 after ism_set_vpls */
};
