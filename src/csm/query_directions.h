/* ---- query: directions to latitude-longitude maps, in steps ---- */

/* Directions to LATLONG maps, a step of samples at a time: cohsm__address, but in loops of constant length without
   branches or calls, which compilers vectorise at -O2 for every instruction set (kernels_directions.h). Step small
   enough that what one loop leaves, or prefetches, is still in the first-level cache for the next. */

enum { COHSM__STEP = 64 };

typedef struct cohsm__step {
    float jitter[5][COHSM__STEP];       /* of the cell's two dimensions, -, and the pixel's */
    float at[4][COHSM__STEP];           /* jittered: in the domain, in cells; -, - or in the map, in pixels */
    int32_t cell[2][COHSM__STEP], valid[COHSM__STEP];
    float angle[4][COHSM__STEP];        /* cos phi, sin phi, cos theta, sin theta */
    float right[3][COHSM__STEP], up[3][COHSM__STEP], back[3][COHSM__STEP];
} cohsm__step;

/* One direction for all points: one frame. Returns the place of the map. */
static uint32_t cohsm__one_frame(const cohsm_maps *m, cohsm__v3 direction, cohsm__frame *f)
{
    int c[3] = { 0, 0, 0 };
    float u[3];

    cohsm__domain_position(m, direction, COHSM_LIGHT_DIRECTION, u);
    c[0] = cohsm__floor(u[0] + 0.5f);
    c[1] = cohsm__floor(u[1] + 0.5f);
    cohsm__wrap(m, c);
    *f = cohsm__cell_frame(&m->head, m->locations, m->angles, cohsm__cell_index(m, c));
    return cohsm__place(m, (uint32_t)c[0], (uint32_t)c[1], 0);
}

/* Neighbours share pixels, so decoded depths are kept by the low bits of x and y. */
static uint32_t cohsm__slot(uint32_t pixel) { return (pixel & 15u) | (pixel >> 3 & 0x1f0u); }

/* One light for many points: pixels and compared depths of up to a stream of them, and what is to be decoded. */
enum { COHSM__STREAM = 1024, COHSM__AHEAD = 768 };      /* floats of points prefetched before they are wanted */

typedef struct cohsm__stream {
    const cohsm_maps *maps;
    cohsm__frame frame;
    uint32_t place;
    float    bias;                      /* in parts of the depth range */
    size_t   count;
    const float *packed;                /* points as they stand in the query; NULL: x, y, z in radii about the centre */
    const float *x, *y, *z;
    cohsm__kept *kept;
    int32_t  pixel[COHSM__STREAM], depth[COHSM__STREAM];
    uint32_t list[COHSM__STREAM], listed;
} cohsm__stream;

static void cohsm__stream_make(cohsm__stream *s, const cohsm_maps *maps, cohsm__v3 direction, float bias,
                               cohsm__kept *kept)
{
    s->maps = maps;
    s->place = cohsm__one_frame(maps, direction, &s->frame);
    s->bias = bias / (float)maps->head.map_side;
    s->kept = kept;
    s->packed = s->x = s->y = s->z = NULL;
}
