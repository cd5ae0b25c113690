/* ---- map: orientations of faces, projection, matrices ---- */

struct rsm_map {
    rsm_desc   desc;               /* with its defaults filled in */
    uint32_t   side, faces;        /* texels a side; how many faces there are */
    uint32_t   room;               /* how many faces the memory holds */
    int        finished;           /* rsm_finish was called */
    int        owned;              /* the memory is ours to free */
    rsm__v3    right, up, axis;    /* of face 0; the light travels along axis */
    float      extent;             /* half the side of a face: of a sun in world units, of others at distance
                                      1 */
    float      cos_half;           /* the cosine of a spot's half angle; -1 for other lights */
    rsm_stats  stats;
    uint64_t   key;                /* of what rsm_redraw drew; 0 = something else may be in the map */
    rsm_texel *texels;
    double    *rows;               /* side * faces + 1 running sums: the flux of all rows before each */
    double    *sums;               /* the flux of each row up to and including the texel */
};

/* Returns where a call says why it fails whose desc may be NULL or without a log: to the map's then. Each of
   the two may be NULL. */
static inline rsm__logger rsm__logger_of_map(const rsm_system *system, const rsm_map *map,
                                             const char *function)
{
    return rsm__logger_of((system && system->log) || !map ? system : &map->desc.system, function);
}

static inline size_t rsm__texel_count(const rsm_map *map)
{
    return (size_t)map->side * map->side * map->faces;
}

static inline int rsm__is_sun(const rsm_map *map) { return map->desc.light.kind == RSM_LIGHT_SUN; }

/* Writes right, up and axis of a face. Faces 0 to 5 of a cube look along axis, right, left, up, down and
   back; a patch has no face that looks back. */
static inline void rsm__face_frame(const rsm_map *map, uint32_t face, rsm__v3 *r, rsm__v3 *u, rsm__v3 *a)
{
    rsm__v3 right = map->right, up = map->up, axis = map->axis;
    *r = right;
    *u = up;
    *a = axis;
    switch (face) {
    case 1: *r = rsm__v3_scale(axis, -1); *a = right; break;
    case 2: *r = axis; *a = rsm__v3_scale(right, -1); break;
    case 3: *u = rsm__v3_scale(axis, -1); *a = up; break;
    case 4: *u = axis; *a = rsm__v3_scale(up, -1); break;
    case 5: *r = rsm__v3_scale(right, -1); *a = rsm__v3_scale(axis, -1); break;
    default: break;
    }
}

/* Returns whether a light has a cube, as spots have above a half angle of 1. */
static inline int rsm__has_cube(const rsm_light *l)
{
    return l->kind == RSM_LIGHT_POINT || l->kind == RSM_LIGHT_PATCH ||
           (l->kind == RSM_LIGHT_SPOT && l->cone_half_angle > 1.0f);
}

/* Returns whether the depths between which a face holds surfaces are in range, and logs if they are not. */
static inline int rsm__check_depths(const rsm__logger *log, const rsm_light *l)
{
    const double low = l->kind == RSM_LIGHT_SUN ? -1e9 : 1e-30;
    if (!rsm__check_range(log, "light.near_depth", (double)l->near_depth, low, 1e9,
                     l->kind == RSM_LIGHT_SUN ? "-1e9..1e9" : "above 0, at most 1e9"))
        return 0;
    if (l->far_depth > l->near_depth && l->far_depth <= 1e9f) return 1;
    rsm__log_value(log, "light.far_depth", (double)l->far_depth, "above near_depth, at most 1e9");
    return 0;
}

/* Returns whether a light has what its kind needs, a direction, a radius, a cone, and logs if it has not. */
static inline int rsm__check_shape(const rsm__logger *log, const rsm_light *l)
{
    float length = rsm__v3_length(rsm__v3_load(l->direction));
    if (l->kind != RSM_LIGHT_POINT && !(length > 1e-15f && length <= 1e15f)) {
        rsm__log_value(log, "the length of light.direction", (double)length, "above 0");
        return 0;
    }
    if (l->kind == RSM_LIGHT_SUN && !(l->radius > 0.0f && l->radius <= 1e9f)) {
        rsm__log_value(log, "light.radius", (double)l->radius, "above 0, at most 1e9");
        return 0;
    }
    if (l->kind == RSM_LIGHT_SPOT && !(l->cone_half_angle > 0.5e-3f && l->cone_half_angle <= 3.14f)) {
        rsm__log_value(log, "light.cone_half_angle", (double)l->cone_half_angle,
                       "above 0.0005, at most 3.14");
        return 0;
    }
    if (l->kind == RSM_LIGHT_SQUARE_SPOT && !(l->cone_half_angle > 0.5e-3f && l->cone_half_angle <= 1.0f)) {
        rsm__log_value(log, "light.cone_half_angle", (double)l->cone_half_angle, "above 0.0005, at most 1");
        return 0;
    }
    return 1;
}

/* Checks a light and fills in its defaults. */
static inline rsm_result rsm__light_check(const rsm__logger *log, rsm_light *l)
{
    const rsm_result bad = RSM_ERR_DESC;
    int i;
    if (!rsm__check_range(log, "light.kind", (double)l->kind, 0, RSM_LIGHT_COUNT - 1,
                     "one of rsm_light_kind"))
        return bad;
    if (l->kind == RSM_LIGHT_DEFAULT) l->kind = RSM_LIGHT_SUN;
    if (!rsm__check_vector(log, "light.position", l->position, 1e9, "-1e9..1e9")) return bad;
    if (!rsm__check_vector(log, "light.direction", l->direction, (double)RSM__MAX_FLOAT, "finite"))
        return bad;
    if (!rsm__check_vector(log, "light.up", l->up, (double)RSM__MAX_FLOAT, "finite")) return bad;
    for (i = 0; i < 3; i++)
        if (!rsm__check_range(log, "light.value", (double)l->value[i], 0, (double)1e12f, "0..1e12"))
            return bad;
    if (!rsm__check_shape(log, l)) return bad;
    if (l->near_depth == 0.0f && l->far_depth == 0.0f) {
        l->near_depth = l->kind == RSM_LIGHT_SUN ? -l->radius : 1e-3f;
        l->far_depth = l->kind == RSM_LIGHT_SUN ? l->radius : 1e3f;
    }
    return rsm__check_depths(log, l) ? RSM_OK : bad;
}

/* Checks a desc and fills in its defaults. */
static inline rsm_result rsm__desc_check(const rsm__logger *log, rsm_desc *d)
{
    rsm_result result = rsm__light_check(log, &d->light);
    if (result != RSM_OK) return result;
    if (!rsm__system_valid(log, &d->system)) return RSM_ERR_DESC;
    if (d->side == 0) d->side = rsm__has_cube(&d->light) ? 256 : 512;
    if (!rsm__check_range(log, "desc.side", d->side, 4, RSM__MAX_SIDE, "0 or 4..4096")) return RSM_ERR_DESC;
    if (!rsm__check_range(log, "desc.clip_depth", (double)d->clip_depth, 0, RSM_CLIP_DEPTH_COUNT - 1,
                     "one of rsm_clip_depth"))
        return RSM_ERR_DESC;
    if (!rsm__check_range(log, "desc.clip_y", (double)d->clip_y, 0, RSM_CLIP_Y_COUNT - 1,
                          "one of rsm_clip_y"))
        return RSM_ERR_DESC;
    if (!rsm__check_range(log, "desc.rows", (double)d->rows, 0, RSM_ROWS_COUNT - 1, "one of rsm_rows"))
        return RSM_ERR_DESC;
    return RSM_OK;
}

/* Checks a desc and sets the map's orientation and sizes by it. If the desc is refused, the map stays as it
   is. */
static inline rsm_result rsm__set_map_desc(const rsm__logger *log, rsm_map *map, const rsm_desc *desc)
{
    rsm_desc d = *desc;
    rsm__v3 up;
    int cube;
    rsm_result result = rsm__desc_check(log, &d);
    if (result != RSM_OK) return result;
    cube = rsm__has_cube(&d.light);
    map->faces = !cube ? 1 : d.light.kind == RSM_LIGHT_PATCH ? 5 : 6;
    map->side = d.side;
    map->desc = d;
    map->axis = d.light.kind == RSM_LIGHT_POINT ? rsm__v3_make(0, 0, -1)
                                                : rsm__v3_normalize(rsm__v3_load(d.light.direction));
    if (d.light.kind == RSM_LIGHT_SUN) map->axis = rsm__v3_scale(map->axis, -1);
    up =
        rsm__v3_normalize(d.light.kind == RSM_LIGHT_POINT ? rsm__v3_make(0, 1, 0) : rsm__v3_load(d.light.up));
    if (rsm__v3_length(rsm__v3_cross(map->axis, up)) < 1e-3f)
        up = fabsf(map->axis.y) < 0.9f ? rsm__v3_make(0, 1, 0) : rsm__v3_make(0, 0, 1);
    map->right = rsm__v3_normalize(rsm__v3_cross(map->axis, up));
    map->up = rsm__v3_cross(map->right, map->axis);
    map->extent = 1.0f;
    map->cos_half = -1.0f;
    if (d.light.kind == RSM_LIGHT_SUN) map->extent = d.light.radius;
    else if (d.light.kind == RSM_LIGHT_SPOT || d.light.kind == RSM_LIGHT_SQUARE_SPOT) {
        float s, c;
        rsm__sincos(d.light.cone_half_angle, &s, &c);
        if (!cube) map->extent = s / c;
        if (d.light.kind == RSM_LIGHT_SPOT) map->cos_half = c;
    }
    return RSM_OK;
}

/* Returns where a point lies in a face: x and y in units of half the face's side, z as the depth. */
static inline rsm__v3 rsm__to_face(const rsm_map *map, uint32_t face, rsm__v3 p)
{
    rsm__v3 r, u, a, q = rsm__v3_sub(p, rsm__v3_load(map->desc.light.position));
    float z, scale;
    rsm__face_frame(map, face, &r, &u, &a);
    z = rsm__v3_dot(q, a);
    scale = rsm__is_sun(map) ? 1.0f / map->extent : 1.0f / (map->extent * z);
    return rsm__v3_make(rsm__v3_dot(q, r) * scale, rsm__v3_dot(q, u) * scale, z);
}

/* Returns the point at depth z under (x, y) of a face, both -1..1. */
static inline rsm__v3 rsm__from_face(const rsm_map *map, uint32_t face, float x, float y, float z)
{
    rsm__v3 r, u, a, p = rsm__v3_load(map->desc.light.position);
    float scale = rsm__is_sun(map) ? map->extent : map->extent * z;
    rsm__face_frame(map, face, &r, &u, &a);
    p = rsm__v3_madd(p, r, x * scale);
    p = rsm__v3_madd(p, u, y * scale);
    return rsm__v3_madd(p, a, z);
}

/* Returns the face by which a direction, given along right, up and axis of the light, leaves the cube. */
static inline uint32_t rsm__cube_face(float x, float y, float z)
{
    float ax = fabsf(x), ay = fabsf(y), az = fabsf(z);
    if (az >= ax && az >= ay) return z >= 0.0f ? 0 : 5;
    if (ax >= ay) return x >= 0.0f ? 1 : 2;
    return y >= 0.0f ? 3 : 4;
}

/* Returns the face that a point lies in; 5, which a patch does not have, for points behind the light. */
static inline uint32_t rsm__face_of(const rsm_map *map, rsm__v3 p)
{
    rsm__v3 q = rsm__v3_sub(p, rsm__v3_load(map->desc.light.position));
    if (map->faces == 1) return 0;
    return rsm__cube_face(rsm__v3_dot(q, map->right), rsm__v3_dot(q, map->up), rsm__v3_dot(q, map->axis));
}

/* Returns the coordinate, -1..1, of the centre of column or row i of a face. */
static inline float rsm__texel_centre(const rsm_map *map, uint32_t i)
{
    return ((float)i + 0.5f) * 2.0f / (float)map->side - 1.0f;
}

/* Returns the unit vector from a point of the scene to the light. */
static inline rsm__v3 rsm__to_light(const rsm_map *map, rsm__v3 p)
{
    if (rsm__is_sun(map)) return rsm__v3_scale(map->axis, -1);
    return rsm__v3_normalize(rsm__v3_sub(rsm__v3_load(map->desc.light.position), p));
}

static inline void rsm__texel_clear(rsm_texel *t)
{
    memset(t, 0, sizeof *t);
    t->depth = RSM_FAR;
}

RSM_DEF rsm_result rsm_map_matrix(const rsm_map *map, uint32_t face, float world_to_clip[16])
{
    rsm__v3 r, u, a, p;
    float n, f, sx;
    float sy, z[2], row[4][4];
    int i, k, perspective;
    rsm__logger log = rsm__logger_of(map ? &map->desc.system : NULL, "rsm_map_matrix");
    if (!map) return RSM_ERR_ARGUMENT;
    if (!world_to_clip) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "world_to_clip", "is NULL");
    if (!rsm__check_face(&log, face, map->faces)) return RSM_ERR_ARGUMENT;
    rsm__face_frame(map, face, &r, &u, &a);
    p = rsm__v3_load(map->desc.light.position);
    n = map->desc.light.near_depth;
    f = map->desc.light.far_depth;
    perspective = !rsm__is_sun(map);
    sx = 1.0f / map->extent;
    sy = map->desc.clip_y == RSM_CLIP_Y_DOWN ? -sx : sx;
    /* Clip z is z[0] depth + z[1], which perspective divides by w = depth. */
    z[0] = perspective ? f / (f - n) : 1.0f / (f - n);
    z[1] = perspective ? -n * f / (f - n) : -n / (f - n);
    if (map->desc.clip_depth == RSM_CLIP_DEPTH_REVERSED) {
        z[0] = perspective ? -n / (f - n) : -z[0];
        z[1] = perspective ? -z[1] : f / (f - n);
    } else if (map->desc.clip_depth != RSM_CLIP_DEPTH_ZERO_TO_ONE) {
        z[0] = 2.0f * z[0] - (perspective ? 1.0f : 0.0f);
        z[1] = 2.0f * z[1] - (perspective ? 0.0f : 1.0f);
    }
    for (i = 0; i < 3; i++) {
        float axis = i == 0 ? a.x : i == 1 ? a.y : a.z;
        row[0][i] = sx * (i == 0 ? r.x : i == 1 ? r.y : r.z);
        row[1][i] = sy * (i == 0 ? u.x : i == 1 ? u.y : u.z);
        row[2][i] = z[0] * axis;
        row[3][i] = perspective ? axis : 0.0f;
    }
    row[0][3] = -sx * rsm__v3_dot(r, p);
    row[1][3] = -sy * rsm__v3_dot(u, p);
    row[2][3] = z[1] - z[0] * rsm__v3_dot(a, p);
    row[3][3] = perspective ? -rsm__v3_dot(a, p) : 1.0f;
    for (i = 0; i < 4; i++)
        for (k = 0; k < 4; k++) world_to_clip[4 * k + i] = row[i][k];
    return RSM_OK;
}

RSM_DEF rsm_result rsm_map_project(const rsm_map *map, const float point[3], uint32_t *face, float uv[2],
                                   float *depth)
{
    rsm__v3 q;
    uint32_t f;
    rsm__logger log = rsm__logger_of(map ? &map->desc.system : NULL, "rsm_map_project");
    if (!map) return RSM_ERR_ARGUMENT;
    if (!point) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "point", "is NULL");
    if (!face) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "face", "is NULL");
    if (!uv) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "uv", "is NULL");
    if (!depth) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "depth", "is NULL");
    if (!rsm__check_vector(&log, "point", point, 1e9, "-1e9..1e9")) return RSM_ERR_INPUT;
    f = rsm__face_of(map, rsm__v3_load(point));
    if (f >= map->faces) f = 0; /* the point lies behind a patch */
    q = rsm__to_face(map, f, rsm__v3_load(point));
    if (!rsm__is_sun(map) && !(q.z > 0.0f)) q.x = q.y = 0.0f;
    *face = f;
    uv[0] = q.x * 0.5f + 0.5f;
    uv[1] = q.y * 0.5f + 0.5f;
    *depth = q.z;
    return RSM_OK;
}
