/* ---- fill: a face from the buffers of a renderer ---- */

/* Returns the depth along the face that a value 0..1 of a depth buffer stands for. */
static inline float rsm__unproject_depth(const rsm_map *map, float stored)
{
    float n = map->desc.light.near_depth, f = map->desc.light.far_depth;
    if (map->desc.clip_depth == RSM_CLIP_DEPTH_REVERSED)
        return rsm__is_sun(map) ? f - stored * (f - n) : n * f / (n + stored * (f - n));
    if (rsm__is_sun(map)) return n + stored * (f - n);
    return n * f / (f - stored * (f - n));
}

static inline float rsm__from_srgb(uint8_t value)
{
    float s = (float)value * (1.0f / 255.0f);
    return s <= 0.04045f ? s * (1.0f / 12.92f) : rsm__pow((s + 0.055f) * (1.0f / 1.055f), 2.4f);
}

typedef struct rsm__filling {
    rsm_map *map;
    uint32_t face;
    const rsm_buffers *buffers;
    float srgb[256];
} rsm__filling;

/* Fills one texel from the buffers. */
static inline void rsm__fill_texel(const rsm__filling *f, uint32_t i, uint32_t j)
{
    rsm_map *map = f->map;
    const rsm_buffers *b = f->buffers;
    /* If the picture is turned, its first row is the top of the face, v = 1. */
    int turned = (map->desc.rows == RSM_ROWS_TOP_FIRST) != (map->desc.clip_y == RSM_CLIP_Y_DOWN);
    size_t at = (size_t)(turned ? map->side - 1u - j : j) * map->side + i;
    rsm__v3 normal = rsm__vector_at(b->normals, b->normal_stride, at), position;
    float stored = b->depth ? *rsm__element_at(b->depth, rsm__stride_or(b->depth_stride, 4), at) : 0.0f;
    float albedo[3] = { 1, 1, 1 };
    uint32_t material = 0;
    int c;
    rsm__texel_clear(map->texels + ((size_t)f->face * map->side + j) * map->side + i);
    if (normal.x == 0.0f && normal.y == 0.0f && normal.z == 0.0f) return;
    if (b->depth && (map->desc.clip_depth == RSM_CLIP_DEPTH_REVERSED ? stored <= 0.0f : stored >= 1.0f))
        return;
    if (b->positions) position = rsm__vector_at(b->positions, b->position_stride, at);
    else
        position = rsm__from_face(map, f->face, rsm__texel_centre(map, i), rsm__texel_centre(map, j),
                                  rsm__unproject_depth(map, stored));
    if (b->albedo) rsm__v3_store(albedo, rsm__vector_at(b->albedo, b->albedo_stride, at));
    else if (b->albedo_srgb)
        for (c = 0; c < 3; c++)
            albedo[c] = f->srgb[b->albedo_srgb[at * rsm__stride_or(b->albedo_srgb_stride, 4) + (size_t)c]];
    if (b->materials)
        memcpy(&material,
               (const char *)(const void *)b->materials + at * rsm__stride_or(b->material_stride, 4),
               sizeof material);
    rsm__texel_set(map, f->face, i, j, position, normal, albedo, material);
}

static inline void rsm__fill_row(void *context, size_t row)
{
    const rsm__filling *f = (const rsm__filling *)context;
    uint32_t i;
    for (i = 0; i < f->map->side; i++) rsm__fill_texel(f, i, (uint32_t)row);
}

static inline rsm_result rsm__buffers_check(const rsm__logger *log, const rsm_buffers *b)
{
    const rsm_result bad = RSM_ERR_ARGUMENT;
    if (!b) return rsm__refuse(log, bad, "buffers", "is NULL");
    if (!b->normals) return rsm__refuse(log, bad, "buffers.normals", "is NULL");
    if (!b->positions && !b->depth)
        return rsm__refuse(log, bad, "buffers.depth", "is NULL, and so is positions");
    if (!rsm__check_stride(log, "buffers.position_stride", b->position_stride, 12)) return bad;
    if (!rsm__check_stride(log, "buffers.depth_stride", b->depth_stride, 4)) return bad;
    if (!rsm__check_stride(log, "buffers.normal_stride", b->normal_stride, 12)) return bad;
    if (!rsm__check_stride(log, "buffers.albedo_stride", b->albedo_stride, 12)) return bad;
    if (!rsm__check_stride(log, "buffers.material_stride", b->material_stride, 4)) return bad;
    if (b->albedo_srgb_stride == 0 || b->albedo_srgb_stride >= 3) return RSM_OK;
    rsm__log_value(log, "buffers.albedo_srgb_stride", (double)b->albedo_srgb_stride, "0 or at least 3");
    return bad;
}

RSM_DEF rsm_result rsm_fill(rsm_map *map, uint32_t face, const rsm_buffers *buffers)
{
    rsm__logger log = rsm__logger_of(map ? &map->desc.system : NULL, "rsm_fill");
    rsm__filling f;
    rsm_result result;
    size_t i, texels;
    if (!map) return RSM_ERR_ARGUMENT;
    result = rsm__buffers_check(&log, buffers);
    if (result != RSM_OK) return result;
    if (!rsm__check_face(&log, face, map->faces)) return RSM_ERR_ARGUMENT;
    if (map->finished) return rsm__refuse(&log, RSM_ERR_ORDER, "map", "is finished");
    f.map = map;
    f.face = face;
    f.buffers = buffers;
    for (i = 0; i < 256; i++) f.srgb[i] = rsm__from_srgb((uint8_t)i);
    if (rsm__run_steps(&map->desc.system, map->side, rsm__fill_row, &f, 0.0f, 1.0f)) return RSM_OK;
    texels = (size_t)map->side * map->side;
    for (i = 0; i < texels; i++) rsm__texel_clear(map->texels + face * texels + i);
    return rsm__refuse(&log, RSM_ERR_CANCELLED, "progress", "cancelled the call");
}
