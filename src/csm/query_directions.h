/* ---- query: directions to latitude-longitude maps, in steps ---- */

/* Samples whose lights are directions, and whose maps are LATLONG, are treated a step of 64 at a time. The
   result is that of cohsm__address, but comes from loops of constant length without branches or calls, which
   compilers vectorise at -O2 for every instruction set (kernels_directions.h). A step is so small that what
   one loop writes or prefetches is still in the first-level cache for the next loop. */

enum { COHSM__STEP = 64 };

typedef struct cohsm__step {
    float jitter[5][COHSM__STEP];       /* of the cell's two dimensions, [2] unused, and of the pixel's two */
    float at[4][COHSM__STEP];           /* jittered position: [0] and [1] in the domain, in cells; [2] and [3]
                                           in the map, in pixels */
    int32_t cell[2][COHSM__STEP], valid[COHSM__STEP];
    float angle[4][COHSM__STEP];        /* cos phi, sin phi, cos theta, sin theta */
    float right[3][COHSM__STEP], up[3][COHSM__STEP], back[3][COHSM__STEP];
} cohsm__step;

/* Writes the axes of the map that answers for one direction, and returns the map's place in the sequence. */
static uint32_t cohsm__axes_toward(const cohsm_maps *m, cohsm__v3 direction, cohsm__axes *f)
{
    int c[3] = { 0, 0, 0 };
    float u[3];

    cohsm__domain_position(m, direction, COHSM_LIGHT_DIRECTION, u);
    c[0] = cohsm__floor(u[0] + 0.5f);
    c[1] = cohsm__floor(u[1] + 0.5f);
    cohsm__wrap_cell(m, c);
    *f = cohsm__cell_axes(&m->head, m->locations, m->angles, cohsm__cell_index(m, c));
    return cohsm__place_of_cell(m, (uint32_t)c[0], (uint32_t)c[1], 0);
}

/* Returns where the decoded depth of a pixel is kept: by the low bits of x and y, since neighbouring points
   share pixels. */
static uint32_t cohsm__slot(uint32_t pixel) { return (pixel & 15u) | (pixel >> 3 & 0x1f0u); }

enum {
    COHSM__STREAM = 1024,               /* the most points of a stream */
    COHSM__AHEAD = 768                  /* floats of points that are prefetched before they are wanted */
};

typedef struct cohsm__stream {          /* points that have one light */
    const cohsm_maps *maps;
    cohsm__axes axes;
    uint32_t place;
    float    bias;                      /* in parts of the depth range */
    size_t   count;
    const float *packed;                /* points as they stand in the query; NULL: x, y, z have them, in
                                           radii about the centre */
    const float *x, *y, *z;
    cohsm__kept *kept;
    /* The caller's room for as many numbers as there are points. */
    int32_t  *pixel;                    /* of each point, or COHSM__NO_PIXEL */
    int32_t  *depth;                    /* of each point, to be compared */
    uint32_t *list;                     /* pixels whose depths are to be decoded */
    uint32_t listed;
} cohsm__stream;

static void cohsm__stream_make(cohsm__stream *s, const cohsm_maps *maps, cohsm__v3 direction, float bias,
                               cohsm__kept *kept)
{
    s->maps = maps;
    s->place = cohsm__axes_toward(maps, direction, &s->axes);
    s->bias = bias / (float)maps->head.map_side;
    s->kept = kept;
    s->packed = s->x = s->y = s->z = NULL;
}
