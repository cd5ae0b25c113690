/* ---- direct light, shadowed by the same map (section 4) ---- */

typedef struct rsm__direct {
    const rsm_map    *map;
    rsm_direct_desc   desc;
    const rsm_points *points;
    float            *out;
} rsm__direct;

/* Returns the irradiance at p without shadow, for a light of value 1. It is 0 outside of a cone and behind a
   patch. */
static inline float rsm__unshadowed_light(const rsm_map *map, rsm__v3 p, rsm__v3 n, rsm__v3 to_light)
{
    rsm__v3 d = rsm__v3_sub(p, rsm__v3_load(map->desc.light.position)), q;
    float d2 = rsm__v3_dot(d, d), cosine = rsm__v3_dot(n, to_light), out = -rsm__v3_dot(map->axis, to_light);
    if (!(cosine > 0.0f)) return 0.0f;
    if (rsm__is_sun(map)) return cosine;
    if (!(d2 > 0.0f)) return 0.0f;
    switch (map->desc.light.kind) {
    case RSM_LIGHT_SPOT: if (!(out >= map->cos_half)) return 0.0f; break;
    case RSM_LIGHT_SQUARE_SPOT:
        q = rsm__to_face(map, 0, p);
        if (!(q.z > 0.0f && fabsf(q.x) <= 1.0f && fabsf(q.y) <= 1.0f)) return 0.0f;
        break;
    case RSM_LIGHT_PATCH: cosine *= out > 0.0f ? out : 0.0f; break;
    default: break;
    }
    return cosine / d2;
}

/* Returns the lit share of tap_side x tap_side texels about p, weighted as by a box whose place is not bound
   to texels. With 2 x 2 the weights are bilinear. */
static inline float rsm__lit_share(const rsm_map *map, const rsm_direct_desc *desc, rsm__v3 p, float cosine)
{
    uint32_t face = rsm__face_of(map, p);
    rsm__v3 q = rsm__to_face(map, face, p);
    float side = (float)map->side, radius = 0.5f * (float)(desc->tap_side - 1);
    float x, y, texel;
    float bias, slope, sum = 0.0f, total = 0.0f;
    float fx, fy;
    uint32_t i, j;
    if (face >= map->faces) return 0.0f;
    if (!rsm__is_sun(map) && !(q.z > 0.0f)) return 0.0f;
    if (!(fabsf(q.x) <= 1.0f && fabsf(q.y) <= 1.0f)) return rsm__is_sun(map) ? 1.0f : 0.0f;
    texel = 2.0f / side * map->extent * (rsm__is_sun(map) ? 1.0f : q.z);
    slope = cosine < 1.0f ? sqrtf(1.0f - cosine * cosine) / (cosine > 0.1f ? cosine : 0.1f) : 0.0f;
    slope = slope < 10.0f ? slope : 10.0f;
    bias = texel * (desc->bias +
                    desc->slope_bias * slope * 0.7072f * (float)desc->tap_side); /* the farthest tap */
    x = (q.x * 0.5f + 0.5f) * side - radius; /* floor(x) is the column of the first tap */
    y = (q.y * 0.5f + 0.5f) * side - radius;
    fx = x - floorf(x);
    fy = y - floorf(y);
    for (j = 0; j < desc->tap_side; j++)
        for (i = 0; i < desc->tap_side; i++) {
            int32_t s = (int32_t)floorf(x) + (int32_t)i, t = (int32_t)floorf(y) + (int32_t)j;
            float weight = (i == 0                ? 1.0f - fx
                            : i == desc->tap_side - 1 ? fx
                                                  : 1.0f) *
                           (j == 0                ? 1.0f - fy
                            : j == desc->tap_side - 1 ? fy
                                                  : 1.0f);
            if (desc->tap_side == 1) weight = 1.0f;
            total += weight;
            s = s < 0 ? 0 : s >= (int32_t)map->side ? (int32_t)map->side - 1 : s;
            t = t < 0 ? 0 : t >= (int32_t)map->side ? (int32_t)map->side - 1 : t;
            if (q.z - bias <=
                map->texels[((size_t)face * map->side + (size_t)t) * map->side + (size_t)s].depth)
                sum += weight;
        }
    return total > 0.0f ? sum / total : 0.0f;
}

/* Lights a batch of 256 receivers. */
static inline void rsm__direct_batch(void *context, size_t batch)
{
    const rsm__direct *w = (const rsm__direct *)context;
    const rsm_points *p = w->points;
    size_t count = p->indices ? p->index_count : p->count, i = batch * 256,
           end = i + 256 < count ? i + 256 : count;
    for (; i < end; i++) {
        size_t at = p->indices ? p->indices[i] : i;
        float light = 0.0f, *out = w->out + 3 * at;
        rsm__v3 x, n;
        uint64_t bad = 0;
        int c;
        if (rsm__load_receiver(p, at, &x, &n, &bad)) {
            rsm__v3 to_light = rsm__to_light(w->map, x);
            light = rsm__unshadowed_light(w->map, x, n, to_light);
            if (light > 0.0f) light *= rsm__lit_share(w->map, &w->desc, x, rsm__v3_dot(n, to_light));
        }
        for (c = 0; c < 3; c++) out[c] = (w->desc.add ? out[c] : 0.0f) + light * w->map->desc.light.value[c];
    }
}

/* Checks a desc, which may be NULL, and writes it with its defaults to out. */
static inline rsm_result rsm__direct_check(const rsm__logger *log, const rsm_direct_desc *desc,
                                           rsm_direct_desc *out)
{
    memset(out, 0, sizeof *out);
    if (desc) *out = *desc;
    if (!rsm__check_range(log, "desc.tap_side", out->tap_side, 0, 15, "0..15")) return RSM_ERR_DESC;
    if (!rsm__check_range(log, "desc.bias", (double)out->bias, -1e6, 1e6, "-1e6..1e6")) return RSM_ERR_DESC;
    if (!rsm__check_range(log, "desc.slope_bias", (double)out->slope_bias, -1e6, 1e6, "-1e6..1e6"))
        return RSM_ERR_DESC;
    if (!rsm__system_valid(log, &out->system)) return RSM_ERR_DESC;
    if (out->tap_side == 0) out->tap_side = 2;
    if (out->bias == 0.0f) out->bias = 0.5f;
    if (out->slope_bias == 0.0f) out->slope_bias = 1.0f;
    out->bias = out->bias > 0.0f ? out->bias : 0.0f;
    out->slope_bias = out->slope_bias > 0.0f ? out->slope_bias : 0.0f;
    return RSM_OK;
}

RSM_DEF rsm_result rsm_direct(const rsm_map *map, const rsm_direct_desc *desc, const rsm_points *points,
                              float *irradiance)
{
    rsm__logger log = rsm__logger_of_map(desc ? &desc->system : NULL, map, "rsm_direct");
    rsm__direct w;
    size_t count;
    rsm_result result;
    if (!map) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "map", "is NULL");
    if (!map->finished)
        return rsm__refuse(&log, RSM_ERR_ORDER, "map", "is not finished: rsm_finish must come first");
    result = rsm__points_check(&log, points, irradiance);
    if (result == RSM_OK) result = rsm__direct_check(&log, desc, &w.desc);
    if (result != RSM_OK) return result;
    w.map = map;
    w.points = points;
    w.out = irradiance;
    count = points->indices ? points->index_count : points->count;
    if (!rsm__run_steps(&w.desc.system, (count + 255) / 256, rsm__direct_batch, &w, 0.0f, 1.0f))
        return rsm__refuse(&log, RSM_ERR_CANCELLED, "progress", "cancelled the call");
    return RSM_OK;
}
