/* ---- maps: their memory ---- */

static inline size_t rsm__align_bytes(size_t bytes) { return (bytes + 15u) & ~(size_t)15u; }

/* Returns the bytes that a map whose desc is set needs, or 0 if that is more than size_t holds. */
static inline size_t rsm__map_bytes(const rsm_map *map)
{
    size_t rows = (size_t)map->side * map->faces, texels, bytes, sums;
    if (!rsm__mul_size(rows, map->side, &texels) || !rsm__mul_size(texels, sizeof(rsm_texel), &bytes))
        return 0;
    if (!rsm__mul_size(texels, sizeof(double), &sums) || !rsm__add_size(bytes, sums, &bytes)) return 0;
    if (!rsm__add_size(bytes, (rows + 1) * sizeof(double) + rsm__align_bytes(sizeof *map) + 64, &bytes))
        return 0;
    return bytes;
}

RSM_DEF size_t rsm_map_bytes(const rsm_desc *desc)
{
    rsm_map map;
    rsm__logger log = rsm__logger_of(desc ? &desc->system : NULL, "rsm_map_bytes");
    return desc && rsm__set_map_desc(&log, &map, desc) == RSM_OK ? rsm__map_bytes(&map) : 0;
}

/* Lays a map whose desc is set out in memory that is large enough, and empties it. */
static inline rsm_map *rsm__map_place(rsm_map map, void *memory)
{
    rsm_map *to = (rsm_map *)memory;
    char *at = (char *)memory + rsm__align_bytes(sizeof map);
    size_t i, texels = rsm__texel_count(&map);
    map.room = map.faces;
    map.texels = (rsm_texel *)(void *)at;
    at += rsm__align_bytes(texels * sizeof(rsm_texel));
    map.sums = (double *)(void *)at;
    map.rows = map.sums + texels;
    *to = map;
    for (i = 0; i < texels; i++) rsm__texel_clear(map.texels + i);
    return to;
}

RSM_DEF rsm_result rsm_map_init(const rsm_desc *desc, void *memory, size_t memory_bytes, rsm_map **out)
{
    rsm__logger log = rsm__logger_of(desc ? &desc->system : NULL, "rsm_map_init");
    rsm_map map;
    rsm_result result;
    if (!desc) return RSM_ERR_ARGUMENT;
    if (!memory) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "memory", "is NULL");
    if (!out) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "out", "is NULL");
    memset(&map, 0, sizeof map);
    result = rsm__set_map_desc(&log, &map, desc);
    if (result != RSM_OK) return result;
    if (rsm__map_bytes(&map) == 0) {
        rsm__log_value(&log, "desc.side", map.side, "less: size_t cannot count the bytes of the map");
        return RSM_ERR_LIMIT;
    }
    if (memory_bytes < rsm__map_bytes(&map)) {
        rsm__log_bound(&log, "memory_bytes", memory_bytes, "at least", rsm__map_bytes(&map),
                       "rsm_map_bytes(desc)");
        return RSM_ERR_MEMORY;
    }
    if ((uintptr_t)memory % 8 != 0)
        return rsm__refuse(&log, RSM_ERR_MEMORY, "memory", "is not 8-byte aligned");
    *out = rsm__map_place(map, memory);
    return RSM_OK;
}

RSM_DEF rsm_result rsm_map_create(const rsm_desc *desc, rsm_map **out)
{
    rsm__logger log = rsm__logger_of(desc ? &desc->system : NULL, "rsm_map_create");
    rsm_map map;
    rsm__allocator a;
    rsm_result result;
    void *memory;
    if (!desc) return RSM_ERR_ARGUMENT;
    if (!out) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "out", "is NULL");
    memset(&map, 0, sizeof map);
    result = rsm__set_map_desc(&log, &map, desc);
    if (result != RSM_OK) return result;
    if (rsm__map_bytes(&map) == 0) {
        rsm__log_value(&log, "desc.side", map.side, "less: size_t cannot count the bytes of the map");
        return RSM_ERR_LIMIT;
    }
    a = rsm__allocator_of(&desc->system);
    memory = rsm__alloc(&a, rsm__map_bytes(&map));
    if (!memory) return rsm__refuse(&log, RSM_ERR_ALLOC, "the allocator", "returned no memory for the map");
    *out = rsm__map_place(map, memory);
    (*out)->owned = 1;
    return RSM_OK;
}

RSM_DEF rsm_result rsm_map_restart(rsm_map *map, const rsm_light *light)
{
    rsm__logger log = rsm__logger_of(map ? &map->desc.system : NULL, "rsm_map_restart");
    rsm_map next;
    rsm_desc desc;
    rsm_result result;
    size_t i, texels;
    if (!map) return RSM_ERR_ARGUMENT;
    desc = map->desc;
    if (light) desc.light = *light;
    memset(&next, 0, sizeof next);
    result = rsm__set_map_desc(&log, &next, &desc);
    if (result != RSM_OK) return result;
    if (next.faces > map->room) {
        rsm__log_bound(&log, "the face count of light", next.faces, "at most", map->room,
                       "what the map was made with");
        return RSM_ERR_LIMIT;
    }
    next.room = map->room;
    next.owned = map->owned;
    next.texels = map->texels;
    texels = rsm__texel_count(&next);
    next.sums = map->sums;
    next.rows = map->rows;
    *map = next;
    for (i = 0; i < texels; i++) rsm__texel_clear(map->texels + i);
    return RSM_OK;
}

RSM_DEF void rsm_map_free(rsm_map *map)
{
    rsm__allocator a;
    if (!map || !map->owned) return;
    a = rsm__allocator_of(&map->desc.system);
    rsm__free(&a, map);
}

RSM_DEF void rsm_get_info(const rsm_map *map, rsm_info *out)
{
    if (!map || !out) return;
    out->side = map->side;
    out->face_count = map->faces;
    out->texel_count = rsm__texel_count(map);
    out->finished = map->finished;
}

RSM_DEF const rsm_texel *rsm_map_texels(const rsm_map *map) { return map ? map->texels : NULL; }
