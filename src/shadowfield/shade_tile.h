/* ---- shading: a tile of sixteen points ---- */

/* What is known of an occluder of a tile: its visibility was not fetched yet; it was; or it need not be. */
enum { SFIELD__NOT_FETCHED, SFIELD__FETCHED, SFIELD__ALL_HIDDEN };

typedef struct sfield__tile {
    const sfield_scene *s;
    const sfield_points *set;
    size_t    first;                            /* number of the first point */
    uint32_t  lanes;                            /* how many points there are */
    uint32_t  active, in_view;                  /* bits: points that can be shaded; those of them that the
                                                   caller sees */
    float     p[48], n[48], view[48];           /* planes, world */
    float     middle[3], extent;                /* a sphere about all lanes */
    uint32_t  count;                            /* occluders that count for some lane: `item` of each, and
                                                   `order` from near to far */
    uint32_t *item, *order;
    uint32_t *used, *shown;                     /* bits: lanes for which an occluder counts; those of them
                                                   for which no nearer one hides it */
    float    *mean, *widest, *farthest;         /* the middle's distance; the greatest sine of the inscribed
                                                   sphere, and the greatest distance, of all lanes */
    float    *d2, *factor, *occlusion;          /* of each occluder: 16, 16 and 16 n^2 floats */
    uint8_t  *state;                            /* of each occluder: SFIELD__NOT_FETCHED, ... */
    uint32_t  lights;                           /* the environment, if there is one, comes after them */
    int       sky;                              /* 1: there is an environment */
    int       chains;                           /* how many T a point has: 1, with gloss 2 or 3 */
    int       all_round;                        /* not 0: occluders below the horizon count too */
    uint16_t *mask;                             /* [light][occluder in order]: lanes for which it is nearer */
    uint64_t  set_hash;                         /* sfield__hash_set, and sfield__hash_brdfs */
    uint64_t *hash, occluders_hash;             /* with a cache: what T of each light depends on, and T behind
                                                   all occluders */
    uint8_t  *needed;                           /* of each light: not 0 if its T has to be computed */
    uint32_t *prefix;                           /* of each light: how many occluders, from the first in order
                                                   on, are nearer than the light for all lanes that they count
                                                   for */
    float    *t;                                /* [light][chain] 16 n^2 */
    float    *start;                            /* [chain] 16 n^2 */
    float    *rows, *planes, *turned;           /* for one entity: 16 rows of 3 channels; planes twice */
    sfield_scene_stats stats;
} sfield__tile;

/* Divides memory among the arrays of one task; with NULL only measures how much they need. 65,535 entities
   need up to 2^34 bytes, which a size_t may not hold. */
static uint64_t sfield__carve_tile(sfield__tile *t, uint8_t *memory, uint32_t occluders, uint32_t lights,
                              uint32_t coefs, uint32_t chains)
{
    uint64_t at = 0, c = coefs * SFIELD__LANES, n = occluders ? occluders : 1, slots = (uint64_t)lights + 1;
#define SFIELD__CARVE(member, type, number)                                \
    do {                                                                   \
        if (memory) t->member = (type *)(void *)(memory + (size_t)at);     \
        at += ((number) * sizeof(type) + 63) / 64 * 64;                    \
    } while (0)
    SFIELD__CARVE(occlusion, float, n * c);
    SFIELD__CARVE(t, float, (slots * chains > 6 ? slots * chains : 6) * c);  /* all, a light's */
    SFIELD__CARVE(start, float, chains * c);
    /* coefficients of a row: a multiple of 8 */
    SFIELD__CARVE(rows, float, 3 * (c + 7 * SFIELD__LANES) + 8);
    SFIELD__CARVE(planes, float, c + 7 * SFIELD__LANES);
    SFIELD__CARVE(turned, float, c);
    SFIELD__CARVE(d2, float, n * SFIELD__LANES);
    SFIELD__CARVE(factor, float, n * SFIELD__LANES);
    SFIELD__CARVE(mean, float, n);
    SFIELD__CARVE(widest, float, n);
    SFIELD__CARVE(farthest, float, n);
    SFIELD__CARVE(prefix, uint32_t, slots);
    SFIELD__CARVE(item, uint32_t, n);
    SFIELD__CARVE(order, uint32_t, n);
    SFIELD__CARVE(used, uint32_t, n);
    SFIELD__CARVE(shown, uint32_t, n);
    SFIELD__CARVE(hash, uint64_t, slots);
    SFIELD__CARVE(mask, uint16_t, slots * n);
    SFIELD__CARVE(state, uint8_t, n);
    SFIELD__CARVE(needed, uint8_t, slots);
#undef SFIELD__CARVE
    return at;
}

#ifndef SFIELD_WITHOUT_GLOSS
/* Returns how many T a point of a set has: one for rgb, with gloss a second for the lobe, or two more for the
   metal-rough BRDF. */
static int sfield__count_chains(const sfield_points *set)
{
    return !set->gloss ? 1 : set->materials ? 3 : set->exponents ? 2 : 1;
}
#endif

static void sfield__load_lanes(sfield__tile *t)
{
    const sfield_points *set = t->set;
    const float *m = !set->entity ? NULL : t->s->item[set->entity - 1].e.transform;
    const float *turn = m ? t->s->item[set->entity - 1].turn : NULL;
    uint32_t l, k;
    t->active = t->in_view = 0;
    for (l = 0; l < SFIELD__LANES; l++) {
        size_t i = t->first + (l < t->lanes ? l : 0);
        sfield__v3 p = sfield__v3_load(sfield__row(set->positions, set->position_stride, i));
        sfield__v3 n = sfield__v3_load(sfield__row(set->normals, set->normal_stride, i)), v = n;
        if (m) {
            p = sfield__m4_point(m, p);
            n = sfield__v3_make(turn[0] * n.x + turn[3] * n.y + turn[6] * n.z,
                                turn[1] * n.x + turn[4] * n.y + turn[7] * n.z,
                                turn[2] * n.x + turn[5] * n.y + turn[8] * n.z);
        }
        if (t->chains > 1)
            v = sfield__v3_load(sfield__row(set->to_eye, set->to_eye_stride, i));
        if (l < t->lanes && sfield__finite(sfield__v3_dot(p, p)) && sfield__v3_dot(n, n) < 1.1f &&
            sfield__v3_dot(v, v) < 1.1f && sfield__v3_dot(n, n) > 0.9f && sfield__v3_dot(v, v) > 0.9f) {
            t->active |= 1u << l;
            if (!set->in_view || set->in_view[i]) t->in_view |= 1u << l;
        } else {
            p = sfield__v3_make(0, 0, 0);
            n = v = sfield__v3_make(0, 1, 0);
        }
        for (k = 0; k < 3; k++) {
            t->p[16 * k + l] = k == 0 ? p.x : k == 1 ? p.y : p.z;
            t->n[16 * k + l] = k == 0 ? n.x : k == 1 ? n.y : n.z;
            t->view[16 * k + l] = k == 0 ? v.x : k == 1 ? v.y : v.z;
        }
    }
}

/* Finds a sphere about the lanes that can be shaded, from the middle of their box. */
static void sfield__bound_lanes(sfield__tile *t)
{
    float most = 0;
    uint32_t k, l;
    for (k = 0; k < 3; k++) {
        float low = 3e38f, high = -3e38f;
        for (l = 0; l < SFIELD__LANES; l++) {
            float x = t->p[16 * k + l];
            if (!(t->active >> l & 1)) continue;
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        t->middle[k] = t->active ? 0.5f * low + 0.5f * high : 0;
        most += t->active ? (high - low) * (high - low) : 0;
    }
    t->extent = 0.5f * sqrtf(most);
}

static void sfield__measure_distances(const float *p, const float *c, float *d2)
{
    int l;
    for (l = 0; l < SFIELD__LANES; l++) {
        float x = c[0] - p[l], y = c[1] - p[16 + l], z = c[2] - p[32 + l];
        d2[l] = x * x + y * y + z * z;
    }
}

/* Computes where the lanes are in a field of an entity: planes, about its center, in r. */
static void sfield__move_to_local(const sfield__item *it, int which, const float *p, float *local, int simd)
{
    sfield__to_local16(it->turn, it->center[which], it->inverse[which], p, local, simd);
}

/* Returns whether light j is the entity that the points lie on. All of its light comes from below their
   horizon, or is hidden by their self-visibility: only ringing would be added, of the strongest light. */
static int sfield__is_own(const sfield__tile *t, uint32_t j)
{
    return j < t->lights && t->s->light[j] + 1 == t->set->entity;
}

/* Returns how many lights a set has, the environment among them, but not the entity that the set lies on. */
static uint32_t sfield__lights_of(const sfield_scene *s, const sfield_points *set, int sky)
{
    return s->light_count + (uint32_t)sky - (set->entity && s->item[set->entity - 1].e.source ? 1u : 0u);
}
