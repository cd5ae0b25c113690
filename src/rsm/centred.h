/* ---- centred: samples about the projection of a receiver (equation 3), and MIXED ---- */

/* MIXED samples a texel in two ways, weighted by the balance heuristic (Veach and Guibas 1995). By flux there
   are n1 P expected samples of the texel, where P is its share of the flux; about the receiver there are B /
   q, where q is the squared distance from the receiver's projection in the map. This function returns B. If
   lights are near, q is small and the second way takes over, with samples so dense that no single one is
   bright. The sum is unbiased by any q that both ways compute alike; this q makes the log-radial density with
   its inner disc rounded off. */
static inline float rsm__mixed_scale(const rsm__gather *g, const rsm_map *map)
{
    /* The density is C / r^2 over a disc of unit radius with r_min = 1/192, so C is 1 / (2 pi (log 192 +
       1/2)). A texel of a cube has 1 / (6 side^2) of the disc's area pi. */
    return (float)g->centred * 0.02764f * (map->faces == 1 ? 1.0f : 0.5236f) /
           ((float)map->side * (float)map->side);
}

/* The r_min of MIXED, which is so small that texels about a corner are taken nearly one by one, and its
   square. */
#define RSM__MIXED_MIN (1.0f / 192.0f)
#define RSM__MIXED_INNER 2.7127e-5f

/* Returns the place of texel (i, j) between which MIXED measures distances: a point of the unit square, or
   for a cube a point of the sphere of diameter 1. */
static inline rsm__v3 rsm__mixed_place(const rsm_map *map, uint32_t face, uint32_t i, uint32_t j)
{
    float u = rsm__texel_centre(map, i), v = rsm__texel_centre(map, j);
    rsm__v3 r, up, a;
    if (map->faces == 1) return rsm__v3_make(u * 0.5f + 0.5f, v * 0.5f + 0.5f, 0.0f);
    rsm__face_frame(map, face, &r, &up, &a);
    return rsm__v3_scale(rsm__v3_normalize(rsm__v3_madd(rsm__v3_madd(a, r, u), up, v)), 0.5f);
}

/* Returns the centre of the patterns about a receiver at p: a point of the unit square, which with `inside`
   is moved into the map, or for a cube a direction, of which two axes across are written to frame. */
static inline rsm__v3 rsm__centre_of(const rsm_map *map, rsm__v3 p, int inside, rsm__v3 frame[2])
{
    rsm__v3 centre;
    if (map->faces != 1) {
        centre = rsm__v3_normalize(rsm__v3_sub(p, rsm__v3_load(map->desc.light.position)));
        if (!(rsm__v3_length(centre) > 0.5f)) centre = map->axis;
        rsm__v3_basis(centre, &frame[0], &frame[1]);
        return centre;
    }
    centre = rsm__to_face(map, 0, p);
    if (!rsm__is_sun(map) && !(centre.z > 0.0f)) centre = rsm__v3_make(0, 0, 0);
    centre = rsm__v3_make(centre.x * 0.5f + 0.5f, centre.y * 0.5f + 0.5f, 0.0f);
    if (inside) {                                /* any centre in the map would do; the nearest is best */
        centre.x = centre.x > 0.02f ? centre.x < 0.98f ? centre.x : 0.98f : 0.02f;
        centre.y = centre.y > 0.02f ? centre.y < 0.98f ? centre.y : 0.98f : 0.02f;
    }
    return centre;
}

/* Returns the number of the texel under a sample of a pattern about the receiver, or (size_t)-1 if the sample
   lies outside of the map, and writes how many texels the sample stands for. centre and frame are those of
   rsm__centre_of. place receives the texel's place for MIXED, and may be NULL. */
static inline size_t rsm__place_sample(const rsm_map *map, float r_max, rsm__v3 centre,
                                       const rsm__v3 frame[2], const float sample[3], float *weight,
                                       rsm__v3 *place)
{
    float x = sample[0], y = sample[1], side = (float)map->side;
    uint32_t i, j, face = 0;
    if (map->faces == 1) {
        float r = r_max;
        if (!(r > 0.0f)) { /* the pattern ends at the border: the ray's length scales both radius and area */
            float length = sqrtf(x * x + y * y), dx, dy;
            if (!(length > 0.0f)) length = 1.0f;
            dx = x / length;
            dy = y / length;
            dx = fabsf(dx) > 1e-9f ? (dx > 0.0f ? 1.0f - centre.x : centre.x) / fabsf(dx) : 4.0f;
            dy = fabsf(dy) > 1e-9f ? (dy > 0.0f ? 1.0f - centre.y : centre.y) / fabsf(dy) : 4.0f;
            r = dx < dy ? dx : dy;
        }
        x = (centre.x + r * x) * side;
        y = (centre.y + r * y) * side;
        *weight = sample[2] * r * r * side * side;
        if (!(r_max > 0.0f)) { /* rounding must not lose samples that lie on the border */
            x = x < 0.0f ? 0.0f : x >= side ? side - 0.5f : x;
            y = y < 0.0f ? 0.0f : y >= side ? side - 0.5f : y;
        }
        if (!(x >= 0.0f && x < side && y >= 0.0f && y < side)) return (size_t)-1;
        i = (uint32_t)x;
        j = (uint32_t)y;
    } else { /* the disc is mapped to the sphere with equal areas: r = sin(angle / 2) */
        float r = r_max > 0.0f && r_max < 1.0f ? r_max : 1.0f, t, height;
        float q, u, v;
        rsm__v3 d, a, right, up;
        x *= r;
        y *= r;
        t = x * x + y * y;
        height = 1.0f - 2.0f * t;
        q = 2.0f * sqrtf(t < 1.0f ? 1.0f - t : 0.0f);
        d = rsm__v3_madd(rsm__v3_madd(rsm__v3_scale(centre, height), frame[0], x * q), frame[1], y * q);
        face = rsm__cube_face(rsm__v3_dot(d, map->right), rsm__v3_dot(d, map->up), rsm__v3_dot(d, map->axis));
        if (face >= map->faces) return (size_t)-1;
        rsm__face_frame(map, face, &right, &up, &a);
        height = rsm__v3_dot(d, a);
        u = rsm__v3_dot(d, right) / height;
        v = rsm__v3_dot(d, up) / height;
        i = (uint32_t)((u * 0.5f + 0.5f) * side);
        j = (uint32_t)((v * 0.5f + 0.5f) * side);
        i = i < map->side ? i : map->side - 1u;
        j = j < map->side ? j : map->side - 1u;
        u = rsm__texel_centre(map, i);
        v = rsm__texel_centre(map, j);
        q = 1.0f + u * u + v * v; /* the solid angle of the texel is (2 / side)^2 / q^1.5 */
        *weight = sample[2] * 4.0f * r * r * 0.25f * side * side * q * sqrtf(q);
    }
    if (place) *place = rsm__mixed_place(map, face, i, j);
    return ((size_t)face * map->side + j) * map->side + i;
}

/* Gathers from the pixel lights that a pattern finds about one receiver. */
static inline void rsm__gather_centred(const rsm__gather *g, const rsm_map *map, const float x[7],
                                       uint32_t set, float noise, rsm__sum *sum)
{
    rsm__v3 frame[2], centre, middle, places[RSM__BLOCK];
    rsm__block block;
    size_t found[RSM__BLOCK];
    float weights[RSM__BLOCK], s = 0.0f, c = 1.0f, scale = rsm__mixed_scale(g, map);
    float total = (float)map->rows[(size_t)map->side * map->faces];
    uint32_t first, i, k, n;
    int nearby = g->desc.near_field > 0.0f;
    frame[0] = frame[1] = rsm__v3_make(0, 0, 0);
    if (g->desc.noise) rsm__sincos(noise * (2.0f * RSM__PI), &s, &c);
    centre = rsm__centre_of(map, rsm__v3_make(x[0], x[1], x[2]), !(g->desc.r_max > 0.0f), frame);
    middle = rsm__v3_scale(centre, map->faces == 1 ? 1.0f : 0.5f);
    for (first = 0; first < g->set_samples; first += RSM__BLOCK) {
        const float *pattern = g->pattern + 3 * ((size_t)set * g->set_samples + first);
        n = g->set_samples - first < RSM__BLOCK ? g->set_samples - first : (uint32_t)RSM__BLOCK;
        for (i = 0; i < n; i++) { /* texels lie all over the map, so all are prefetched before any is read */
            const float *p = pattern + 3 * i, sample[3] = { p[0] * c - p[1] * s, p[0] * s + p[1] * c, p[2] };
            found[i] = rsm__place_sample(map, g->desc.r_max, centre, frame, sample, &weights[i],
                                         g->shared ? &places[i] : NULL);
            if (found[i] != (size_t)-1) RSM__PREFETCH(&map->texels[found[i]].flux);
        }
        for (i = 0; g->shared && i < n; i++) {
            rsm__v3 d;
            float q;
            if (found[i] == (size_t)-1) continue;
            d = rsm__v3_sub(places[i], middle);
            q = (rsm__v3_dot(d, d) + RSM__MIXED_INNER) * (float)g->shared *
                rsm__mean3(map->texels[found[i]].flux);
            if (total > 0.0f) weights[i] *= scale / (q / total + scale);
        }
        for (i = 0; i < n; i++)
            if (found[i] != (size_t)-1 &&
                (g->desc.materials || rsm__mean3(map->texels[found[i]].flux) > 0.0f))
                rsm__lane_set(&g->desc, &block, i, map->texels + found[i], weights[i], (float)g->sets);
            else rsm__lane_clear(&block, i);
        for (; i % RSM__LANES; i++) rsm__lane_clear(&block, i);
        for (k = 0; nearby && k < n; k++)
            if (found[k] != (size_t)-1) rsm__lane_near(&g->desc, map, &block, k, found[k]);
        if (nearby) rsm__kernel_near(g, map, &block, i, x, sum);
        else g->kernel(&block, i, x, sum);
        for (i = 0; g->desc.materials && i < n; i++) {
            rsm__gloss gloss;
            if (found[i] == (size_t)-1 || map->texels[found[i]].material == 0) continue;
            rsm__gloss_set(&g->desc, map, &gloss, found[i], weights[i] * (float)g->sets);
            rsm__add_gloss(
                &gloss, &block, i, x,
                nearby && rsm__is_near(&block, i, x) ? rsm__near_texel_form(map, &block, i, x) : -1.0f, sum);
        }
    }
}

/* Returns the share of a map's flux that lies beyond r_max of a receiver at p. */
static inline double rsm__outside_share(const rsm_map *map, float r_max, rsm__v3 p)
{
    double outside = 0.0, total = map->rows[(size_t)map->side * map->faces];
    size_t at, face = (size_t)map->side * map->side, count = rsm__texel_count(map);
    rsm__v3 q = rsm__to_face(map, 0, p), centre;
    if (!(total > 0.0)) return 0.0;
    centre = rsm__v3_normalize(rsm__v3_sub(p, rsm__v3_load(map->desc.light.position)));
    if (map->faces == 1 && !rsm__is_sun(map) && !(q.z > 0.0f)) q = rsm__v3_make(0, 0, 0);
    for (at = 0; at < count; at++) {
        float u = rsm__texel_centre(map, (uint32_t)(at % map->side));
        float v = rsm__texel_centre(map, (uint32_t)(at % face / map->side));
        float f = rsm__mean3(map->texels[at].flux), d;
        if (!(f > 0.0f)) continue;
        if (map->faces == 1) d = 0.25f * ((u - q.x) * (u - q.x) + (v - q.y) * (v - q.y));
        else {
            rsm__v3 there = rsm__from_face(map, (uint32_t)(at / face), u, v, 1.0f);
            there = rsm__v3_normalize(rsm__v3_sub(there, rsm__v3_load(map->desc.light.position)));
            d = 0.5f * (1.0f - rsm__v3_dot(there, centre));
        }
        if (d > r_max * r_max) outside += (double)f;
    }
    return outside / total;
}
