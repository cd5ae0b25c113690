/* ---- tile: one VPL's map while it is drawn, and the discs that are drawn into it ---- */

/* The points of one tile that are set up together, in arrays of one float each, so that kernels work on
   several at a time. `place` reads the fields up to b1 and b2, which it also overwrites, and writes the
   others. */
typedef struct ism__discs {
    uint32_t count;                             /* points in use */
    uint32_t triangle[ISM__DISCS];
    float    corners[3][3][ISM__DISCS];         /* of the triangles: corner, then coordinate */
    float    weight[ISM__DISCS];                /* area that the point stands for, over its triangle's */
    float    b1[ISM__DISCS], b2[ISM__DISCS];    /* barycentric coordinates of the point; 0 if the disc is not
                                                   cut off at its triangle's edges */
    float    d1[3][ISM__DISCS], d2[3][ISM__DISCS];  /* gradients of these coordinates, in the tile's axes */
    float    at[3][ISM__DISCS];                 /* the disc's centre, in the tile's axes */
    float    g[3][ISM__DISCS];                  /* the disc's plane, as in ism__texel */
    float    radius2[ISM__DISCS];
    int32_t  box[4][ISM__DISCS];                /* first and last column, first and last row */
} ism__discs;

typedef struct ism__tile {          /* one VPL's map while it is drawn */
    const ism_maps  *m;
    const ism_mesh  *mesh;
    const ism_vpl   *vpl;
    ism__orientation axes;
    ism_projection   projection;
    uint32_t         size;
    const ism__window *window;      /* NULL: the whole square */
    const float     *x, *y, *z;     /* directions of texel centres, in the tile's axes; in maps of directions
                                       x and y in units of the radius, and 1 */
    float           *depth;         /* at texel centres; ISM_FAR = empty */
    ism__texel      *texels;
    float            texels_per_unit;   /* the most texels of a radian along a side of the square, without
                                           a window; in maps of directions those of a unit of length */
    uint64_t         splats, wide, filled;
} ism__tile;

typedef struct ism__splat {         /* kernels of one instruction set */
    uint32_t (*place)(ism__tile *tile, ism__discs *s);
    /* Finds where discs lie in the tile. Returns a bit for each disc that may cover a texel. */
    void     (*draw)(ism__tile *tile, const ism__discs *s, uint32_t bits);
    /* Draws the discs whose bits are set, one after the other. */
} ism__splat;

/* Returns the depth of the surfel's plane at a texel; 0 if the texel's ray does not meet the plane. */
static float ism__plane_depth(const ism__tile *tile, const float g[3], size_t i)
{
    float s = g[0] * tile->x[i] + g[1] * tile->y[i] + g[2] * tile->z[i];
    if (tile->vpl->directional) return s > 0.0f ? s : 0.0f;
    return s > 1e-20f ? 1.0f / s : 0.0f;
}

/* Returns ism__tile's texels_per_unit, by its projection. */
static float ism__texels_per_unit(const ism__tile *tile)
{
    float size = (float)tile->size;
    if (tile->vpl->directional) return 0.5f * size / tile->m->radius;
    if (tile->projection == ISM_PROJECTION_PARABOLOID) return 0.5f * size;
    if (tile->projection == ISM_PROJECTION_LOBE)
        return 0.9f * size * sqrtf(0.5f * (tile->vpl->exponent + 1.0f));
    return 0.9f * size;
}
