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
    float depth[COHSM__STEP];           /* in 16 bits, less the bias */
    int32_t cell[2][COHSM__STEP], valid[COHSM__STEP];
    float angle[4][COHSM__STEP];        /* cos phi, sin phi, cos theta, sin theta */
    float right[3][COHSM__STEP], up[3][COHSM__STEP], back[3][COHSM__STEP];
} cohsm__step;

/* Finds the cell of the map that answers for one light. Returns 0 if there is none, so that every point is
   lit. */
static int cohsm__cell_of_light(const cohsm_maps *m, cohsm_light_kind kind, cohsm__v3 l, uint32_t index,
                                uint32_t *cell)
{
    int c[3] = { 0, 0, 0 }, k;
    float f[3];

    *cell = index;
    if (kind == COHSM_LIGHT_INDEX) return index < m->head.map_count;
    if (!cohsm__v3_finite(l) || (kind != COHSM_LIGHT_PARAMETER && !cohsm__length_usable(l))) return 0;
    cohsm__domain_position(m, l, kind, f);
    for (k = 0; k < (int)m->head.dimensions; k++) c[k] = cohsm__floor(f[k] + 0.5f);
    cohsm__wrap_cell(m, c);
    *cell = cohsm__cell_index(m, c);
    return 1;
}

/* A point's key says in which pixel of which map it falls: the pixel's number within the shard and, above
   COHSM__KEY_BITS, the face of a cube map. */
enum { COHSM__KEY_BITS = 20 };          /* M is at most 1024 */

/* Returns where the decoded depth of a key is kept: by the low bits of x and y, since neighbouring points
   share pixels. */
static uint32_t cohsm__slot(uint32_t key) { return (key & 15u) | (key >> 3 & 0x1f0u); }

enum {
    COHSM__STREAM = 1024,               /* the most points of a stream */
    COHSM__AHEAD = 3072                 /* bytes of points that are prefetched before they are wanted */
};

typedef struct cohsm__stream {          /* points that have one light */
    const cohsm_maps *maps;
    cohsm__axes axes;                   /* of maps of directions */
    cohsm__v3 eye;                      /* of cube maps, in radii about the centre */
    uint32_t place;                     /* of the map; of a cube map, that of its first face */
    float    bias;                      /* the query's */
    size_t   count;
    const char *points;                 /* as they stand in the query, `stride` bytes apart; NULL: x, y, z
                                           have them, in radii about the centre */
    size_t   stride;
    const float *x, *y, *z;
    cohsm__kept *kept;
    /* The caller's room for as many numbers as there are points. */
    int32_t  *key;                      /* of each point, or -1 if it falls into no pixel */
    int32_t  *depth;                    /* of each point, to be compared */
    uint32_t *list;                     /* keys whose depths are to be decoded */
    uint32_t listed;
} cohsm__stream;

/* Makes a stream for the map of a cell, which is still without points. */
static void cohsm__stream_make(cohsm__stream *s, const cohsm_maps *m, uint32_t cell, float bias,
                               cohsm__kept *kept)
{
    uint32_t c[3];

    memset(s, 0, sizeof *s);
    cohsm__cell_split(m->head.side, cell, c);
    s->maps = m;
    s->place = cohsm__place_of_cell(m, c[0], c[1], c[2]);
    s->bias = bias;
    s->kept = kept;
    if (m->head.positional) {
        s->eye = cohsm__v3_sub(cohsm__cell_location(&m->head, m->locations, cell),
                               cohsm__v3_load(m->head.center));
        s->eye = cohsm__v3_scale(s->eye, 1.0f / m->head.radius);
    } else s->axes = cohsm__cell_axes(&m->head, m->locations, m->angles, cell);
}
