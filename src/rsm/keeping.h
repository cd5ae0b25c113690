/* ---- keeping: maps whose light and meshes are what they were ---- */

enum { RSM__READ = 32768 };        /* rows of an array that one task reads */

typedef struct rsm__rows {         /* rows of an array of a mesh, and the number that their bytes make */
    const void *base;
    size_t      stride, each;      /* bytes from one row to the next, and those of a row that count */
    size_t      count;
    uint64_t    key;
} rsm__rows;

/* Returns a number that is another one for another word, and, if the words are the same, for another key: so
   one word that differs always makes another key, and several that do miss it once in 2^64. */
static inline uint64_t rsm__key_with(uint64_t key, uint64_t word)
{
    key = (key ^ word) * 0x9e3779b97f4a7c15u;
    return key ^ key >> 32;
}

/* Returns the key of bytes, after one that is given. Four keys run side by side, since each waits for its
   product. */
static inline uint64_t rsm__key_of_bytes(uint64_t key, const void *data, size_t bytes)
{
    const char *at = (const char *)data;
    uint64_t lanes[4], words[4];
    int k;
    for (k = 0; k < 4; k++) lanes[k] = key + (uint64_t)k;
    key = rsm__key_with(key, bytes);
    while (bytes) {
        size_t some = bytes < sizeof words ? bytes : sizeof words;
        if (some < sizeof words) memset(words, 0, sizeof words);
        memcpy(words, at, some);
        for (k = 0; k < 4; k++) lanes[k] = rsm__key_with(lanes[k], words[k]);
        at += some;
        bytes -= some;
    }
    for (k = 0; k < 4; k++) key = rsm__key_with(key, lanes[k]);
    return key;
}

/* Finds the key of some rows; rows that do not lie one right after the other are put so first. */
static inline void rsm__read_rows(void *context, size_t index)
{
    rsm__rows *r = (rsm__rows *)context + index;
    const char *at = (const char *)r->base;
    float row[64 * 3];
    size_t i, n;
    r->key = 0;
    if (r->stride == r->each) r->key = rsm__key_of_bytes(0, at, r->count * r->each);
    for (; r->stride != r->each && r->count; r->count -= n) { /* the rows of vertices, of 12 bytes */
        n = r->count < 64 ? r->count : (size_t)64;
        for (i = 0; i < n; i++, at += r->stride) memcpy(row + 3 * i, at, r->each);
        r->key = rsm__key_of_bytes(r->key, row, n * r->each);
    }
}

/* Cuts an array into pieces that tasks read. Writes none if `out` is NULL; returns how many there are. */
static inline size_t rsm__cut_rows(rsm__rows *out, const void *base, size_t stride, size_t each, size_t count)
{
    size_t pieces = count / RSM__READ + (count % RSM__READ != 0), i;
    for (i = 0; out && i < pieces; i++) {
        out[i].base = (const char *)base + i * RSM__READ * stride;
        out[i].stride = stride;
        out[i].each = each;
        out[i].count = i + 1 < pieces ? (size_t)RSM__READ : count - i * RSM__READ;
    }
    return pieces;
}

/* Cuts the arrays of all meshes into pieces. Returns how many there are. */
static inline size_t rsm__cut_meshes(rsm__rows *out, const rsm_mesh *meshes, size_t mesh_count)
{
    size_t i, n = 0;
    for (i = 0; i < mesh_count; i++) {
        const rsm_mesh *m = meshes + i;
        n += rsm__cut_rows(out ? out + n : NULL, m->positions, rsm__stride_or(m->vertex_stride, 12), 12,
                           m->vertex_count);
        if (m->indices) n += rsm__cut_rows(out ? out + n : NULL, m->indices, 4, 4, m->index_count);
        if (m->indices16) n += rsm__cut_rows(out ? out + n : NULL, m->indices16, 2, 2, m->index_count);
    }
    return n;
}

/* Returns the key of what a mesh says beside its arrays. What its functions say has version for a key. */
static inline uint64_t rsm__key_of_fields(uint64_t key, const rsm_mesh *m)
{
    const int has_indices = m->indices != NULL, has_indices16 = m->indices16 != NULL;
    const int functions = (m->mask_fn != NULL) + 2 * (m->surface_fn != NULL);
    key = rsm__key_with(key, m->vertex_count);
    key = rsm__key_with(key, has_indices || has_indices16 ? m->index_count : 0);
    key = rsm__key_with(key, (uint64_t)(has_indices + 2 * has_indices16 + 4 * functions));
    key = rsm__key_with(key, functions ? m->version : 0);
    key = rsm__key_with(key, (uint64_t)m->material << 32 | m->tap_side);
    key = rsm__key_of_bytes(key, m->albedo, sizeof m->albedo);
    return rsm__key_of_bytes(key, m->transform, m->transform ? 16 * sizeof(float) : 0);
}

/* Finds the key of all that a map is drawn from: 0 if functions may say anything. */
static inline rsm_result rsm__find_key(const rsm__logger *log, const rsm_map *map, const rsm_light *light,
                                       const rsm_mesh *meshes, size_t mesh_count, uint64_t *out)
{
    rsm__allocator a = rsm__allocator_of(&map->desc.system);
    uint64_t key = rsm__key_of_bytes(1, light, sizeof *light);
    rsm__rows *rows;
    size_t i, n;
    *out = 0;
    for (i = 0; i < mesh_count; i++) {
        const rsm_mesh *m = meshes + i;
        rsm_result result = rsm__arrays_check(log, m, i);
        if (result != RSM_OK) return result;
        if ((m->mask_fn || m->surface_fn) && m->version == 0) return RSM_OK;
        key = rsm__key_of_fields(key, m);
    }
    n = rsm__cut_meshes(NULL, meshes, mesh_count);
    rows = (rsm__rows *)rsm__alloc_array(&a, n + 1, sizeof *rows);
    if (!rows) return rsm__refuse(log, RSM_ERR_ALLOC, "the allocator", "returned no memory for keys");
    rsm__cut_meshes(rows, meshes, mesh_count);
    rsm__run_tasks(&map->desc.system, n, rsm__read_rows, rows);
    for (i = 0; i < n; i++) key = rsm__key_with(key, rows[i].key);
    rsm__free(&a, rows);
    *out = key ? key : 1;
    return RSM_OK;
}

RSM_DEF rsm_result rsm_redraw(rsm_map *map, const rsm_light *light, const rsm_mesh *meshes, size_t mesh_count,
                              int *kept, rsm_stats *stats)
{
    rsm__logger log = rsm__logger_of(map ? &map->desc.system : NULL, "rsm_redraw");
    rsm_light now;
    uint64_t key;
    rsm_stats own;
    rsm_result result;
    int same;
    if (!map) return RSM_ERR_ARGUMENT;
    if (!meshes && mesh_count) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "meshes", "is NULL");
    now = light ? *light : map->desc.light;
    result = rsm__light_check(&log, &now);
    if (result == RSM_OK) result = rsm__find_key(&log, map, &now, meshes, mesh_count, &key);
    if (result != RSM_OK) return result;
    same = key && map->finished && map->key == key;
    if (!same) {
        result = rsm_map_restart(map, &now);
        if (result == RSM_OK) result = rsm_rasterize(map, meshes, mesh_count);
        if (result == RSM_OK) result = rsm_finish(map, &own);
        if (result != RSM_OK) return result;
        map->key = key;
    }
    if (kept) *kept = same;
    if (stats) *stats = map->stats;
    return RSM_OK;
}
