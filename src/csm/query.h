/* ---- query: which pixel of which map answers, and what it says ---- */

/* Samples are treated in tiles: first the map, the pixel and the depth of every sample are found; then the
   stored depths are searched in steps that each prefetch what the next step reads, so that cache misses
   overlap. */

enum {
    COHSM__TILE = 256,                  /* samples of a tile */
    COHSM__KEPT = 512                   /* slots for decoded depths: by 4 bits of x and 5 of y, for M = 128 */
};
#define COHSM__NO_PIXEL UINT32_MAX      /* the sample is outside the map or not finite, and so lit */

#if defined(__GNUC__) && !defined(__TINYC__)
#define COHSM__FLATTEN __attribute__((flatten))
#else
#define COHSM__FLATTEN
#endif

typedef struct cohsm__kept {            /* depths of one light that earlier samples decoded, by cohsm__slot */
    int32_t key[COHSM__KEPT], depth[COHSM__KEPT];
} cohsm__kept;

#ifndef COHSM_WITHOUT_SIMD
typedef struct cohsm__fractions {       /* of PCF: what the sixteen pixels of a sample have in common */
    float   weight[4][COHSM__TILE];     /* how far it lies towards the next cell or pixel, 0..1 */
    int16_t cell[2][COHSM__TILE], pixel[2][COHSM__TILE];    /* the lower one, perhaps one step outside */
    uint8_t valid[COHSM__TILE];         /* 0: no map answers */
} cohsm__fractions;
#endif

typedef struct cohsm__tile {            /* one object's samples, in its space */
    const cohsm_maps  *maps;
    const cohsm_query *query;
    uint32_t seed;                      /* of ROULETTE: each instance draws its own numbers, for else products
                                           would have another mean than those of PCF */
    size_t   count;
    cohsm_light_kind light_kind;        /* the query's; positions become directions on the way */
    int      one_light;                 /* not 0: light[.][0] is the light of all samples */
    float    point[3][COHSM__TILE];     /* in radii about the sphere's centre */
    float    light[3][COHSM__TILE];     /* a direction, a position in radii, or parameters */
    uint32_t cell[COHSM__TILE];         /* the cell that COHSM_LIGHT_INDEX names */
    size_t   id[COHSM__TILE];           /* the sample's number in the query */
    float    visible[COHSM__TILE];      /* the answers */
    uint32_t pixel[COHSM__TILE];        /* the pixel that the sample falls into, or COHSM__NO_PIXEL */
    uint32_t place[COHSM__TILE];        /* the place of its map in the sequence */
    int32_t  depth[COHSM__TILE];        /* the sample's depth, to be compared with the stored one */
    union {                             /* no tile needs both */
        cohsm__kept kept;               /* of NEAREST with one light */
#ifndef COHSM_WITHOUT_SIMD
        cohsm__fractions fractions;     /* of PCF */
#endif
    } work;
} cohsm__tile;

/* In a scene, samples are tested against the spheres of several instances at once, and ask those alone that
   their rays may meet. */
enum {
    COHSM__BLOCK = 2048,                /* samples that are tested at a time */
    COHSM__BUNCH = 16                   /* instances */
};
#define COHSM__SLACK 1e-5f              /* rounding of a transform, as a part of the coordinates */

/* What shadows lies inside the sphere, which is that of the maps in the world and somewhat larger. Maps
   answer with a direction that lies by up to an angle off the light's: `slope` is its tangent, `cone_radius`
   the radius over its cosine. */
typedef struct cohsm__sphere { float x, y, z, radius, cone_radius, slope; } cohsm__sphere;

typedef struct cohsm__bunch {
    uint32_t      count;
    cohsm__sphere sphere[COHSM__BUNCH];
    uint32_t      asked[COHSM__BUNCH][COHSM__BLOCK / 32];   /* a bit for each sample */
} cohsm__bunch;

static void cohsm__keep_nothing(cohsm__kept *kept)
{
    memset(kept->key, 0xff, sizeof kept->key);              /* -1 */
    memset(kept->depth, 0, sizeof kept->depth);
}

static void cohsm__tile_start(cohsm__tile *t, const cohsm_query *q, const cohsm_maps *maps, uint32_t instance)
{
    t->maps = maps;
    t->query = q;
    t->seed = q->seed + 0x9e3779b9u * instance;
    t->light_kind = q->light_kind;
    t->one_light = q->one_light;
    t->count = 0;
    if (q->one_light) cohsm__keep_nothing(&t->work.kept);
}

/* Writes the continuous position of a light in the domain, in units of cells, so that the centres of cells
   are whole numbers. */
static void cohsm__domain_position(const cohsm_maps *m, cohsm__v3 l, cohsm_light_kind kind, float f[3])
{
    const uint32_t *s = m->head.side;
    float u[3];
    int i;

    u[0] = l.x;
    u[1] = l.y;
    u[2] = l.z;
    if (kind == COHSM_LIGHT_DIRECTION || kind == COHSM_LIGHT_POSITION) {
        if (m->head.domain == COHSM_DOMAIN_LATLONG) {
            u[0] = 0.5f + cohsm__atan2(l.z, l.x) * 0.159154943f;
            u[1] = cohsm__acos(l.y / cohsm__v3_length(l)) * 0.318309886f;
        } else cohsm__octa_square(cohsm__v3_normalize(l), u, u + 1);
    }
    for (i = 0; i < 3; i++) {
        float top = (float)s[i];
        f[i] = i < (int)m->head.dimensions ? u[i] * top : 0.0f;
        if (!(f[i] >= 0.0f)) f[i] = 0.0f;
        if (f[i] > top) f[i] = top;
        f[i] -= 0.5f;
    }
}

static int cohsm__floor(float x)
{
    int i = (int)x;
    return (float)i > x ? i - 1 : i;
}

/* Brings a cell one step outside back: around the seam, over a pole, across the edge of the octahedral
   square, or to the border. */
static void cohsm__wrap_cell(const cohsm_maps *m, int *c)
{
    int n0 = (int)m->head.side[0], n1 = (int)m->head.side[1], i;
    uint32_t kind = m->head.domain;

    if (kind == COHSM_DOMAIN_LATLONG || kind == COHSM_DOMAIN_SPHERE) {
        if (c[1] < 0 || c[1] >= n1) c[0] += n0 / 2;
        if (c[0] < 0) c[0] += n0;
        while (c[0] >= n0) c[0] -= n0;
    } else if (kind == COHSM_DOMAIN_OCTAHEDRAL) {
        if (c[0] < 0 || c[0] >= n0) c[1] = n1 - 1 - c[1];
        else if (c[1] < 0 || c[1] >= n1) c[0] = n0 - 1 - c[0];
    }
    for (i = 0; i < 3; i++) {
        if (c[i] < 0) c[i] = 0;
        if (c[i] >= (int)m->head.side[i]) c[i] = (int)m->head.side[i] - 1;
    }
}

static uint32_t cohsm__cell_index(const cohsm_maps *m, const int *c)
{
    return (uint32_t)c[0] + m->head.side[0] * ((uint32_t)c[1] + m->head.side[1] * (uint32_t)c[2]);
}

/* A point as one map sees it: its position in pixels, its depth in 16 bits, and the face of the cube. */
typedef struct cohsm__projected { float x, y, depth; uint32_t face; } cohsm__projected;

static cohsm__projected cohsm__project_point(const cohsm_maps *m, uint32_t cell, cohsm__v3 p, float bias)
{
    float half = 0.5f * (float)m->head.map_side, w;
    cohsm__projected s;
    cohsm__axes f;
    cohsm__v3 q;

    s.face = 0;
    if (!m->head.positional) {
        f = cohsm__cell_axes(&m->head, m->locations, m->angles, cell);
        s.x = cohsm__v3_dot(p, f.right) * half + half;
        s.y = cohsm__v3_dot(p, f.up) * half + half;
        s.depth =
            (0.5f - 0.5f * cohsm__v3_dot(p, f.back) - bias / (float)m->head.map_side) * (float)COHSM__HIT_MAX;
        return s;
    }
    q = cohsm__v3_sub(cohsm__cell_location(&m->head, m->locations, cell), cohsm__v3_load(m->head.center));
    q = cohsm__v3_sub(p, cohsm__v3_scale(q, 1.0f / m->head.radius));
    s.face = cohsm__face_of(q);
    cohsm__face_coordinates(s.face, q, &s.x, &s.y, &w);
    s.x = s.x / w * half + half;
    s.y = s.y / w * half + half;
    s.depth = w * (1.0f - 2.0f * bias / (float)m->head.map_side) * (m->head.radius / m->head.depth_far) *
              (float)COHSM__HIT_MAX;
    return s;
}

static int32_t cohsm__compared_depth(float depth)
{
    if (!(depth >= 0.0f)) return -1;
    return depth < 65535.0f ? (int32_t)depth : 65535;
}

static uint32_t cohsm__pixel(const cohsm_maps *m, float x, float y)
{
    float top = (float)m->head.map_side;
    uint32_t p;
    if (m->head.positional) {                       /* rounding may leave the face by a hair */
        x = x < 0.0f ? 0.0f : x >= top ? top - 0.5f : x;
        y = y < 0.0f ? 0.0f : y >= top ? top - 0.5f : y;
    }
    if (!(x >= 0.0f && x < top && y >= 0.0f && y < top)) return COHSM__NO_PIXEL;
    p = (uint32_t)y * m->head.map_side + (uint32_t)x;
    return p >= m->head.pixel_begin && p < m->head.pixel_end ? p - m->head.pixel_begin : COHSM__NO_PIXEL;
}

static float cohsm__lit_at(const cohsm_maps *m, uint32_t pixel, uint32_t place, int32_t depth)
{
    if (pixel == COHSM__NO_PIXEL || depth < 0) return 1.0f;
    return depth > (int32_t)cohsm__stored_depth(m, pixel, place) ? 0.0f : 1.0f;
}

/* Returns how dark four pixels of one map make a point. Weights of generalised PCF are products of one
   fraction for each of the d + 2 dimensions (paper 4.5). The dark part is summed, so that a sample which
   nothing shadows is exactly 1. */
static float cohsm__pcf_map(const cohsm_maps *m, const int *c, cohsm__v3 p, float bias)
{
    uint32_t place = cohsm__place_of_cell(m, (uint32_t)c[0], (uint32_t)c[1], (uint32_t)c[2]), corner;
    cohsm__projected s = cohsm__project_point(m, cohsm__cell_index(m, c), p, bias);
    float x, y, fx, fy;
    float dark = 0.0f;
    int32_t depth = cohsm__compared_depth(s.depth);

    if (!(fabsf(s.x) < 1e6f && fabsf(s.y) < 1e6f)) return 0.0f;
    place += s.face * m->head.map_count;
    x = (float)cohsm__floor(s.x - 0.5f);
    y = (float)cohsm__floor(s.y - 0.5f);
    fx = s.x - 0.5f - x;
    fy = s.y - 0.5f - y;
    for (corner = 0; corner < 4; corner++) {
        float weight = (corner & 1u ? fx : 1.0f - fx) * (corner & 2u ? fy : 1.0f - fy);
        uint32_t pixel = cohsm__pixel(m, x + (float)(corner & 1u) + 0.5f, y + (float)(corner >> 1) + 0.5f);
        if (weight > 0.0f) dark += weight * (1.0f - cohsm__lit_at(m, pixel, place, depth));
    }
    return dark;
}

static float cohsm__pcf(const cohsm_maps *m, const float *f, cohsm__v3 p, float bias)
{
    uint32_t d = m->head.dimensions, corner, i;
    float dark = 0.0f;

    for (corner = 0; corner < 1u << d; corner++) {
        float weight = 1.0f;
        int c[3] = { 0, 0, 0 };
        for (i = 0; i < d; i++) {
            int low = cohsm__floor(f[i]);
            float fraction = f[i] - (float)low;
            weight *= corner >> i & 1u ? fraction : 1.0f - fraction;
            c[i] = low + (int)(corner >> i & 1u);
        }
        if (!(weight > 0.0f)) continue;
        cohsm__wrap_cell(m, c);
        dark += weight * cohsm__pcf_map(m, c, p, bias);
    }
    return dark;
}

/* Returns the lit part; where all is dark, rounding of the weights may have left a little. */
static float cohsm__lit_from_dark(float dark) { return dark >= 0.999999f ? 0.0f : 1.0f - dark; }

static cohsm__v3 cohsm__tile_point(const cohsm__tile *t, size_t i)
{
    return cohsm__v3_make(t->point[0][i], t->point[1][i], t->point[2][i]);
}

static cohsm__v3 cohsm__tile_light(const cohsm__tile *t, size_t i)
{
    if (t->one_light) i = 0;
    return cohsm__v3_make(t->light[0][i], t->light[1][i], t->light[2][i]);
}

/* Returns a random number for ROULETTE and 0.5 for other filters. Roulette takes the nearest neighbour of a
   position moved at random by up to half a step: a fraction f is rounded up with probability f, which is its
   weight in PCF. */
static float cohsm__jitter(const cohsm__tile *t, uint32_t id, uint32_t dimension)
{
    return t->query->filter == COHSM_FILTER_ROULETTE ? cohsm__random(t->seed, id, dimension) : 0.5f;
}

/* Says whether a direction has a length that can be computed. */
static int cohsm__length_usable(cohsm__v3 l)
{
    float length = cohsm__v3_length(l);
    return length > 0.0f && length < 3.4e38f;
}

/* Finds map, pixel and depth of sample i; with PCF it finds the visibility at once. */
static void cohsm__address(cohsm__tile *t, size_t i)
{
    const cohsm_maps *m = t->maps;
    const cohsm_query *q = t->query;
    cohsm__v3 p = cohsm__tile_point(t, i), l = cohsm__tile_light(t, i);
    cohsm__projected s;
    float f[3] = { 0, 0, 0 };
    uint32_t k, id = (uint32_t)t->id[i];
    int c[3] = { 0, 0, 0 };

    if (!cohsm__v3_finite(p) || (t->light_kind != COHSM_LIGHT_INDEX && !cohsm__v3_finite(l))) return;
    if (t->light_kind == COHSM_LIGHT_INDEX) {
        if (t->cell[t->one_light ? 0 : i] >= m->head.map_count) return;     /* lit, as by a light at NaN */
        cohsm__cell_split(m->head.side, t->cell[t->one_light ? 0 : i], (uint32_t *)c);
        if (q->filter == COHSM_FILTER_PCF) {
            t->visible[i] = cohsm__lit_from_dark(cohsm__pcf_map(m, c, p, q->bias));
            return;
        }
    } else {
        if (t->light_kind != COHSM_LIGHT_PARAMETER && !cohsm__length_usable(l)) return;
        cohsm__domain_position(m, l, t->light_kind, f);
        if (q->filter == COHSM_FILTER_PCF) {
            t->visible[i] = cohsm__lit_from_dark(cohsm__pcf(m, f, p, q->bias));
            return;
        }
        for (k = 0; k < m->head.dimensions; k++) c[k] = cohsm__floor(f[k] + cohsm__jitter(t, id, k));
        cohsm__wrap_cell(m, c);
    }
    s = cohsm__project_point(m, cohsm__cell_index(m, c), p, q->bias);
    if (q->filter == COHSM_FILTER_ROULETTE) {
        s.x += cohsm__jitter(t, id, 3) - 0.5f;
        s.y += cohsm__jitter(t, id, 4) - 0.5f;
    }
    t->depth[i] = cohsm__compared_depth(s.depth);
    if (t->depth[i] < 0) return;
    t->pixel[i] = cohsm__pixel(m, s.x, s.y);
    t->place[i] =
        cohsm__place_of_cell(m, (uint32_t)c[0], (uint32_t)c[1], (uint32_t)c[2]) + s.face * m->head.map_count;
}

/* The search for the stored depth of one of the tile's samples: `at` points to its list first, then to its
   block, and view counts from there. */
typedef struct cohsm__found { const uint32_t *at; uint32_t view, sample; } cohsm__found;

/* Says whether a semi-local light must be refused, since it is inside the hull. */
static int cohsm__light_refused(const cohsm_maps *m, cohsm__v3 l)
{
    int i;
    for (i = 0; i < COHSM__DOP_AXES; i++) {
        float d = cohsm__v3_dot(cohsm__dop_axis(i), l);
        if (d < m->dop[2 * i] || d > m->dop[2 * i + 1]) return 0;
    }
    return 1;
}

/* Says whether the object may stand between a point and a semi-local light outside the hull, which is so if
   the segment between them meets the hull. Beyond the light the ray may meet the hull as well (T67); but the
   maps, which know directions only, must not be asked then. */
static int cohsm__hull_between(const cohsm_maps *m, cohsm__v3 p, cohsm__v3 l)
{
    float enter = 0.0f, leave = 1.0f;
    int i;
    for (i = 0; i < COHSM__DOP_AXES; i++) {
        cohsm__v3 a = cohsm__dop_axis(i);
        float from = cohsm__v3_dot(a, p), step = cohsm__v3_dot(a, l) - from, t0, t1;
        if (step == 0.0f) {
            if (from < m->dop[2 * i] || from > m->dop[2 * i + 1]) return 0;
            continue;
        }
        t0 = (m->dop[2 * i] - from) / step;
        t1 = (m->dop[2 * i + 1] - from) / step;
        if (t0 > t1) {
            float swap = t0;
            t0 = t1;
            t1 = swap;
        }
        if (t0 > enter) enter = t0;
        if (t1 < leave) leave = t1;
        if (enter > leave) return 0;
    }
    return 1;
}
