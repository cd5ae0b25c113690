/* ---- draw: meshes and foreign depths into the tiles ---- */

typedef struct envsh__draw {
    envsh_maps *maps;
    const envsh_mesh *mesh;
    const float *transform;
    size_t triangles, stride;
} envsh__draw;

/* Returns the number of the vertex at corner i of the mesh, three corners to a triangle. */
static size_t envsh__index_at(const envsh_mesh *mesh, size_t i)
{
    return mesh->indices ? mesh->indices[i] : mesh->indices16 ? mesh->indices16[i] : i;
}

/* Writes where the corners of a triangle lie in the tile, for its mask. */
static void envsh__place_mask(const float *rows, const float *const *corners, envsh__mask *mask)
{
    int i, k;
    for (i = 0; i < 3; i++) {
        for (k = 0; k < 2; k++) {
            const float *row = rows + 4 * k, *p = corners[i];
            mask->corners[3 * i + k] = (double)row[0] * (double)p[0] + (double)row[1] * (double)p[1] +
                                       (double)row[2] * (double)p[2] + (double)row[3];
        }
        mask->corners[3 * i + 2] = 1.0;
    }
}

/* Draws the mesh into the tile of light i. */
static void envsh__draw_task(void *context, size_t i)
{
    const envsh__draw *d = (const envsh__draw *)context;
    const envsh_maps *m = d->maps;
    const envsh_view *v = &m->views[i];
    const char *positions = (const char *)d->mesh->positions;
    envsh__tile_target to;
    envsh__mask mask;
    envsh__corner3 c[8];
    const float *p[3];
    float rows[12];
    size_t t, k;
    to.tile = envsh__tile_texels(m, (uint32_t)i, &to.row);
    to.step = m->channels;
    mask.mesh = d->mesh;
    to.low = (int64_t)m->guard;
    to.high = (int64_t)(m->map_side - m->guard) - 1;
    for (k = 0; k < 3; k++)
        if (d->transform) envsh__combine_row(v->lookup + 4 * k, d->transform, rows + 4 * k);
        else memcpy(rows + 4 * k, v->lookup + 4 * k, 4 * sizeof *rows);
    for (t = 0; t < d->triangles; t++) {
        int within = 1, n = 3, j;
        for (k = 0; k < 3; k++) {
            size_t index = envsh__index_at(d->mesh, 3 * t + k);
            p[k] = (const float *)(const void *)(positions + index * d->stride);
            within &= envsh__transform_corner(rows, p[k], &c[k]);
        }
        if (!within) n = envsh__cut_triangle(rows, p, c);
        if (d->mesh->mask_fn) envsh__place_mask(rows, p, &mask);
        mask.triangle = (uint32_t)t;
        for (j = 2; j < n; j++)
            envsh__raster_triangle(&to, d->mesh->mask_fn ? &mask : NULL, &c[0], &c[j - 1], &c[j]);
    }
}

/* Checks a mesh and writes how many triangles the mesh has. */
static envsh_result envsh__check_mesh(const envsh_mesh *mesh, size_t *triangles, const envsh__logger *log)
{
    const int indexed = mesh->indices || mesh->indices16;
    size_t i, n = indexed ? mesh->index_count : mesh->vertex_count;
    size_t stride = mesh->vertex_stride ? mesh->vertex_stride : 12;
    if (!mesh->positions && n)
        return envsh__refuse_text(log, "mesh.positions", "is NULL", ENVSH_ERR_ARGUMENT);
    if (!envsh__stride_fits(mesh->vertex_stride))
        return envsh__refuse_stride(log, "mesh.vertex_stride", mesh->vertex_stride);
    if (mesh->vertex_count && stride > SIZE_MAX / mesh->vertex_count)
        return envsh__refuse(log, "mesh.vertex_count", (double)mesh->vertex_count,
                             "less: the mesh has more bytes than there are addresses", ENVSH_ERR_LIMIT);
    if (mesh->indices && mesh->indices16)
        return envsh__refuse_text(log, "mesh.indices, mesh.indices16", "are both given", ENVSH_ERR_ARGUMENT);
    if (n % 3)
        return envsh__refuse(log, indexed ? "mesh.index_count" : "mesh.vertex_count", (double)n,
                             "a multiple of 3", ENVSH_ERR_ARGUMENT);
    for (i = 0; indexed && i < n; i++)
        if (envsh__index_at(mesh, i) >= mesh->vertex_count) {
            envsh__log_index(log, "mesh", i, envsh__index_at(mesh, i), mesh->vertex_count);
            return ENVSH_ERR_INPUT;
        }
    *triangles = n / 3;
    return ENVSH_OK;
}

/* Checks whether maps can be drawn into: they have texels, and a frame was begun. */
static envsh_result envsh__check_phase(const envsh_maps *m, const envsh__logger *log)
{
    if (m->no_depth) return envsh__refuse_no_depth(log);
    if (!m->phase) return envsh__refuse_text(log, "envsh_maps_begin", "must come first", ENVSH_ERR_ORDER);
    return ENVSH_OK;
}

ENVSH_DEF envsh_result envsh_maps_draw(envsh_maps *m, const envsh_mesh *mesh, const float transform[16])
{
    envsh__draw d;
    envsh__logger logger;
    envsh_result result;
    if (!m) return ENVSH_ERR_ARGUMENT;
    logger = envsh__make_logger(&m->system, "envsh_maps_draw");
    if (!mesh) return envsh__refuse_text(&logger, "mesh", "is NULL", ENVSH_ERR_ARGUMENT);
    if (transform && !envsh__m4_is_affine(transform))
        return envsh__refuse_text(&logger, "transform", "is not affine", ENVSH_ERR_INPUT);
    result = envsh__check_phase(m, &logger);
    if (result == ENVSH_OK) result = envsh__check_mesh(mesh, &d.triangles, &logger);
    if (result != ENVSH_OK) return result;
    d.maps = m;
    d.mesh = mesh;
    d.transform = transform;
    d.stride = mesh->vertex_stride ? mesh->vertex_stride : 12;
    m->phase = 1;
    return envsh__run_steps(m, m->count, envsh__draw_task, &d);
}

ENVSH_DEF envsh_result envsh_maps_set(envsh_maps *m, uint32_t light, const float *depth, size_t row_stride)
{
    size_t row, x, y, packed;
    size_t stride = row_stride;
    envsh__logger logger;
    envsh_result result;
    float *tile;
    if (!m) return ENVSH_ERR_ARGUMENT;
    logger = envsh__make_logger(&m->system, "envsh_maps_set");
    packed = (size_t)m->map_side * 4;
    if (!depth) return envsh__refuse_text(&logger, "depth", "is NULL", ENVSH_ERR_ARGUMENT);
    result = envsh__check_phase(m, &logger);
    if (result != ENVSH_OK) return result;
    if (light >= m->count) return envsh__refuse_light(&logger, light, m->count);
    if (!stride) stride = packed;
    if (stride < packed || stride % 4)
        return envsh__refuse(&logger, "row_stride", (double)stride,
                             "0, or a multiple of 4 from 4 map_side on", ENVSH_ERR_ARGUMENT);
    tile = envsh__tile_texels(m, light, &row);
    for (y = m->guard; y < m->map_side - m->guard; y++)
        for (x = m->guard; x < m->map_side - m->guard; x++) {
            float z = ((const float *)(const void *)((const char *)depth + y * stride))[x];
            if (m->clip_depth == ENVSH_CLIP_DEPTH_REVERSED) z = 1.0f - z;
            tile[y * row + x * m->channels] = z < ENVSH__NOTHING ? (z > 0.0f ? z : 0.0f) : ENVSH__NOTHING;
        }
    m->phase = 1;
    return ENVSH_OK;
}

ENVSH_DEF envsh_bounds envsh_bounds_of(const envsh_mesh *meshes, size_t count, const float *transforms)
{
    envsh_bounds b;
    size_t i, j;
    int c;
    for (c = 0; c < 3; c++) {
        b.low[c] = 1e15f;
        b.high[c] = -1e15f;
    }
    for (i = 0; meshes && i < count; i++) {
        size_t stride = meshes[i].vertex_stride ? meshes[i].vertex_stride : 12;
        for (j = 0; meshes[i].positions && j < meshes[i].vertex_count; j++) {
            envsh__v3 p = envsh__v3_load((const float *)(const void *)((const char *)meshes[i].positions +
                                                                       j * stride));
            float q[3];
            if (transforms) p = envsh__m4_point(transforms + 16 * i, p);
            envsh__v3_store(q, p);
            for (c = 0; c < 3 && envsh__v3_finite(p); c++) {
                float v = q[c] > 1e15f ? 1e15f : q[c] < -1e15f ? -1e15f : q[c];
                b.low[c] = v < b.low[c] ? v : b.low[c];
                b.high[c] = v > b.high[c] ? v : b.high[c];
            }
        }
    }
    return b;
}

/* Finds the least and greatest depth of each cell of tile i, by which most filters need no texel at all. */
static void envsh__bounds_task(void *context, size_t i)
{
    const envsh_maps *m = (const envsh_maps *)context;
    size_t row, x, y;
    float *tile, *out = m->bounds + 2 * i * m->cells * m->cells;
    tile = envsh__tile_texels(m, (uint32_t)i, &row);
    for (y = 0; y < (size_t)m->cells * m->cells; y++) {
        out[2 * y] = ENVSH__NOTHING;
        out[2 * y + 1] = 0.0f;
    }
    for (y = 0; y < m->map_side; y++)
        for (x = 0; x < m->map_side; x++) {
            float z = tile[y * row + x * m->channels];
            float *cell = out + 2 * (y / ENVSH__CELL * m->cells + x / ENVSH__CELL);
            if (z < cell[0]) cell[0] = z;
            if (z > cell[1]) cell[1] = z;
        }
}

ENVSH_DEF envsh_result envsh_maps_end(envsh_maps *m)
{
    envsh__logger logger;
    envsh_result result;
    if (!m) return ENVSH_ERR_ARGUMENT;
    logger = envsh__make_logger(&m->system, "envsh_maps_end");
    result = envsh__check_phase(m, &logger);
    if (result != ENVSH_OK) return result;
    envsh__for_each(&m->system, m->count, envsh__bounds_task, m);
    m->phase = 2;
    return ENVSH_OK;
}
