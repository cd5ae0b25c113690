/* ---- sources: what a gather takes its light from ---- */

/* The box about the positions of some lights, and most2, the largest squared distance at which one of them is
   near. A receiver that is farther from the box than that has none of them near. */
typedef struct rsm__reach { float low[3], high[3], most2; } rsm__reach;

typedef struct rsm__source {       /* the pixel lights of one map, or of a list */
    const rsm_map *map;            /* NULL: a list */
    rsm__block    *blocks;         /* the lights that all receivers share, set by set */
    rsm__gloss    *gloss;          /* their lobes, or NULL */
    uint32_t      *numbers;        /* of each lane, as visible_fn knows it; NULL without such a function */
    size_t         set_blocks;     /* blocks of one set */
    size_t         set_lights;     /* lights of one set */
    size_t         set_lanes;      /* lanes of these lights, a multiple of RSM__LANES */
    rsm__reach    *reaches;        /* of each block, then of each run of blocks; NULL: all lights are points
                                      */
    size_t         set_runs;       /* runs of one set */
} rsm__source;

typedef struct rsm__tally {        /* what one task has counted */
    uint64_t evaluated, pairs, bad;
    double   full, lost;           /* sums of those of rsm__sum */
    double   outside, looked;      /* the sum of shares of flux outside r_max, and of how many receivers */
} rsm__tally;

typedef struct rsm__gather {       /* one call of rsm_gather, rsm_gather_list or rsm_interpolate */
    const rsm_map *const *maps;
    rsm_gather_desc   desc;                      /* with its defaults filled in */
    const rsm_points *points;
    float            *out;
    rsm__source      *sources;
    size_t            source_count;
    size_t            count;                     /* receivers */
    float            *pattern;                   /* x, y and weight of each sample, set by set */
    uint32_t          sets;                      /* interleave^2 */
    size_t            numbered;                  /* lights of the sources before that visible_fn knows */
    uint32_t          set_samples;               /* samples of the pattern in each set */
    uint32_t          shared, centred;           /* samples that all receivers share, and samples about each
                                                    receiver; MIXED has both */
    rsm__kernel       kernel;
    rsm__receiver_lanes_kernel lanes_kernel;
    size_t            receiver_lane_count;
    rsm__tally       *tallies;                   /* one for each batch or row */
    float             scale;                     /* the factor of results, 1 / pi */
    float            *reach2;                    /* receives the squared distance of each point's nearest
                                                    light; may be NULL */
} rsm__gather;

/* Puts a light into lane i. weight says how many such texels the light stands for, sets how many sets share
   the lights. A light counts `sets` times in its set, but its bound is that of the light among all sets, so
   that interleaving changes nothing on average. */
static inline void rsm__lane_set(const rsm_gather_desc *d, rsm__block *k, size_t i, const rsm_texel *t,
                                 float weight, float sets)
{
    float cap = d->clamp > 0.0f ? d->clamp : RSM__NO_CAP;
    if (d->near_limit > 0.0f && t->area * weight > 0.0f) {
        float own = d->near_limit * RSM__PI / (t->area * weight);
        cap = own < cap ? own : cap;
    }
    k->px[i] = t->position[0] - d->offset * t->normal[0];
    k->py[i] = t->position[1] - d->offset * t->normal[1];
    k->pz[i] = t->position[2] - d->offset * t->normal[2];
    k->rounding[i] = rsm__rounding(k->px[i], k->py[i], k->pz[i]);
    k->nx[i] = t->normal[0];
    k->ny[i] = t->normal[1];
    k->nz[i] = t->normal[2];
    k->r[i] = t->flux[0] * weight * sets;
    k->g[i] = t->flux[1] * weight * sets;
    k->b[i] = t->flux[2] * weight * sets;
    k->cap[i] = cap;
}

/* Notes in lane i the squared distance within which its texel is near, and the face that the texel lies in.
   */
static inline void rsm__lane_near(const rsm_gather_desc *d, const rsm_map *map, rsm__block *k, size_t i,
                                  size_t at)
{
    float area = map->texels[at].area;
    k->density[i] = d->near_field * d->near_field * (area > 0.0f ? area : 0.0f);
    k->lx[i] = map->faces == 1 ? 0.0f : (float)(at / ((size_t)map->side * map->side));
}

static inline void rsm__lane_clear(rsm__block *k, size_t i)
{
    k->px[i] = k->py[i] = k->pz[i] = k->nx[i] = k->ny[i] = k->nz[i] = k->r[i] = k->g[i] = k->b[i] = 0.0f;
    k->rounding[i] = 0.0f;
    k->cap[i] = RSM__NO_CAP;
    k->lx[i] = k->ly[i] = k->lz[i] = k->density[i] = 0.0f;
}

/* Makes the Phong lobe of texel number `at` of a map. The lobe of a texel without a material is 0. */
static inline void rsm__gloss_set(const rsm_gather_desc *d, const rsm_map *map, rsm__gloss *g, size_t at,
                                  float weight)
{
    const rsm_texel *t = map->texels + at;
    size_t face = (size_t)map->side * map->side;
    rsm__v3 n = rsm__v3_load(t->normal), l = rsm__to_light(map, rsm__v3_load(t->position));
    float incident;
    int c;
    memset(g, 0, sizeof *g);
    if (t->material == 0 || t->material > d->material_count || !(t->depth < RSM_FAR)) return;
    rsm__v3_store(g->mirror, rsm__v3_sub(rsm__v3_scale(n, 2.0f * rsm__v3_dot(n, l)), l));
    g->exponent = d->materials[t->material - 1].exponent;
    incident = rsm__texel_incident(map, (uint32_t)(at / face), (uint32_t)(at % map->side),
                             (uint32_t)(at % face / map->side));
    for (c = 0; c < 3; c++)
        g->scale[c] = incident * map->desc.light.value[c] * weight *
                      d->materials[t->material - 1].specular[c] * 0.5f * (g->exponent + 2.0f);
}

/* Picks sample i of n in proportion to flux: writes the number of its texel and how many such texels it
   stands for. Returns 0 where the map has no flux. */
static inline int rsm__pick_texel(const rsm_map *map, uint32_t i, uint32_t n, uint32_t seed, size_t *at,
                                  float *weight)
{
    double total = map->rows[map->side * (size_t)map->faces], x, flux;
    uint32_t low = 0, high = map->side * map->faces, row;
    const double *sums;
    float u, v;
    if (!(total > 0.0)) return 0;
    /* Samples are a lattice: rows at even steps of flux, places in a row by the golden ratio, both shifted by
       the seed. */
    u = rsm__fraction(rsm__to_unit(i * 2654435769u) + rsm__random(seed, 5, 0));
    v = ((float)i + rsm__random(seed, 6, 0)) / (float)n;
    x = (double)(v < 0.99999994f ? v : 0.99999994f) * total;
    while (high - low > 1u) {
        uint32_t middle = low + (high - low) / 2u;
        if (map->rows[middle] <= x) low = middle;
        else high = middle;
    }
    row = low;
    sums = map->sums + (size_t)row * map->side;
    x = (double)(u < 0.99999994f ? u : 0.99999994f) * sums[map->side - 1];
    low = 0;
    high = map->side - 1; /* the first texel whose sum exceeds x is searched */
    while (low < high) {
        uint32_t middle = low + (high - low) / 2u;
        if (sums[middle] > x) high = middle;
        else low = middle + 1u;
    }
    flux = sums[low] - (low ? sums[low - 1] : 0.0);
    if (!(flux > 0.0)) return 0;
    *at = (size_t)row * map->side + low;
    *weight = (float)(total / ((double)n * flux));
    return 1;
}
