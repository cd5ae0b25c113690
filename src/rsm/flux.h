/* ---- flux: light through a texel, and sums of it ---- */

/* Returns the flux of a light of value 1 through the square (x, y) +- h in the plane of a face at distance 1.
   That is the integral of cos^3, for a patch times the cosine to its normal, by Gauss points: two an axis if
   the square is small, else four. It is exact to 1e-6, and nothing cancels as in the closed form by
   arctangents. The rim of a cone is left to rsm__texel_incident. */
static inline float rsm__solid_angle(const rsm_map *map, rsm__v3 r, rsm__v3 u, rsm__v3 a, float x, float y,
                                     float h)
{
    static const float node[6] = { -0.577350269f, 0.577350269f, -0.861136312f,
                                   -0.339981044f, 0.339981044f, 0.861136312f };
    static const float weight[6] = { 0.5f, 0.5f, 0.173927423f, 0.326072577f, 0.326072577f, 0.173927423f };
    float sum = 0.0f;
    int i, j, first = h < 0.05f ? 0 : 2, end = h < 0.05f ? 2 : 6;
    for (j = first; j < end; j++)
        for (i = first; i < end; i++) {
            float s = x + h * node[i], t = y + h * node[j], q = 1.0f / (1.0f + s * s + t * t);
            float f = q * sqrtf(q);
            if (map->desc.light.kind == RSM_LIGHT_PATCH) {
                float c = rsm__v3_dot(map->axis, rsm__v3_madd(rsm__v3_madd(a, r, s), u, t)) * sqrtf(q);
                f = c > 0.0f ? f * c : 0.0f;
            }
            sum += f * weight[i] * weight[j];
        }
    return sum * 4.0f * h * h;
}

/* Returns whether the direction to (x, y) in the plane of a face at distance 1 lies in the spot's cone. */
static inline int rsm__in_cone(const rsm_map *map, rsm__v3 r, rsm__v3 u, rsm__v3 a, float x, float y)
{
    rsm__v3 d = rsm__v3_madd(rsm__v3_madd(a, r, x), u, y);
    return rsm__v3_dot(map->axis, d) >= map->cos_half * rsm__v3_length(d);
}

/* Returns the flux of a light of value 1 through a texel. A texel across the rim of a cone has the share of
   64 points that lie in the cone. */
static inline float rsm__texel_incident(const rsm_map *map, uint32_t face, uint32_t i, uint32_t j)
{
    rsm__v3 r, u, a;
    float h = map->extent / (float)map->side, x = rsm__texel_centre(map, i) * map->extent;
    float y = rsm__texel_centre(map, j) * map->extent, flux;
    int k, l, corners = 0, covered = 0;
    if (rsm__is_sun(map)) return 4.0f * h * h;
    rsm__face_frame(map, face, &r, &u, &a);
    flux = rsm__solid_angle(map, r, u, a, x, y, h);
    if (map->desc.light.kind != RSM_LIGHT_SPOT) return flux;
    for (k = 0; k < 4; k++) corners += rsm__in_cone(map, r, u, a, x + (k & 1 ? h : -h), y + (k & 2 ? h : -h));
    if (corners == 4) return flux;
    if (corners == 0 && !rsm__in_cone(map, r, u, a, x, y)) return 0.0f;
    for (l = 0; l < 8; l++)
        for (k = 0; k < 8; k++)
            covered += rsm__in_cone(map, r, u, a, x + h * ((float)k - 3.5f) * 0.25f,
                                    y + h * ((float)l - 3.5f) * 0.25f);
    return flux * (float)covered * (1.0f / 64.0f);
}

/* Sets one texel to a surface at a position, with the light that falls on it and leaves it. */
static inline void rsm__texel_set(rsm_map *map, uint32_t face, uint32_t i, uint32_t j, rsm__v3 position,
                                  rsm__v3 normal, const float albedo[3], uint32_t material)
{
    rsm_texel *t = map->texels + ((size_t)face * map->side + j) * map->side + i;
    rsm__v3 q = rsm__to_face(map, face, position);
    float incident = rsm__texel_incident(map, face, i, j), slope, distance;
    int c, bad;
    normal = rsm__v3_normalize(normal);
    bad = !rsm__is_usable(position) || !rsm__v3_finite(normal) || !rsm__finite(q.z);
    for (c = 0; c < 3; c++)
        bad |= !(albedo[c] >= 0.0f && albedo[c] * incident * map->desc.light.value[c] <= 1e18f);
    rsm__texel_clear(t);
    if (bad) {
        t->material = UINT32_MAX; /* by this rsm_finish counts the texel as bad */
        return;
    }
    rsm__v3_store(t->position, position);
    rsm__v3_store(t->normal, normal);
    t->depth = q.z;
    t->material = material == UINT32_MAX ? 0 : material;
    for (c = 0; c < 3; c++) t->flux[c] = incident * map->desc.light.value[c] * albedo[c];
    /* The area of surface under the texel: the cross section of its beam over the cosine, which counts as
       0.05 at least. */
    slope = fabsf(rsm__v3_dot(normal, rsm__to_light(map, position)));
    distance = rsm__is_sun(map) ? 1.0f : q.z * map->extent;
    t->area = 4.0f * distance * distance / ((float)map->side * (float)map->side) *
              (rsm__is_sun(map) ? map->extent * map->extent : 1.0f);
    if (!rsm__is_sun(map)) { /* the plane of the face cuts the beam at an angle */
        rsm__v3 r, u, a;
        rsm__face_frame(map, face, &r, &u, &a);
        t->area *= fabsf(rsm__v3_dot(a, rsm__to_light(map, position)));
    }
    t->area /= slope > 0.05f ? slope : 0.05f;
}

/* Makes the running sums of flux, in double, and the statistics. A texel that was marked as bad is counted
   here. */
static inline void rsm__sum_flux(rsm_map *map, int want_incident)
{
    size_t i, at = 0, rows = (size_t)map->side * map->faces, row;
    double total = 0.0;
    map->stats.lit_texels = map->stats.bad_texels = 0;
    for (i = 0; i < 3; i++) map->stats.incident[i] = map->stats.reflected[i] = 0.0;
    for (row = 0; row < rows; row++) {
        double sum = 0.0;
        map->rows[row] = total;
        for (i = 0; i < map->side; i++, at++) {
            rsm_texel *t = map->texels + at;
            int c;
            if (t->material == UINT32_MAX) {
                t->material = 0;
                map->stats.bad_texels++;
            }
            if (t->depth < RSM_FAR) {
                float f = !want_incident ? 0.0f
                                         : rsm__texel_incident(map, (uint32_t)(row / map->side), (uint32_t)i,
                                                               (uint32_t)(row % map->side));
                for (c = 0; c < 3; c++) {
                    map->stats.incident[c] += (double)(f * map->desc.light.value[c]);
                    map->stats.reflected[c] += (double)t->flux[c];
                }
            }
            sum += (double)rsm__mean3(t->flux);
            map->stats.lit_texels += rsm__mean3(t->flux) > 0.0f;
            map->sums[at] = sum;
        }
        total += sum;
    }
    map->rows[rows] = total;
}

RSM_DEF rsm_result rsm_finish(rsm_map *map, rsm_stats *stats)
{
    rsm__logger log = rsm__logger_of(map ? &map->desc.system : NULL, "rsm_finish");
    if (!map) return RSM_ERR_ARGUMENT;
    if (map->finished) return rsm__refuse(&log, RSM_ERR_ORDER, "map", "is finished already");
    rsm__sum_flux(map, stats != NULL);
    map->finished = 1;
    if (stats) *stats = map->stats;
    return RSM_OK;
}
